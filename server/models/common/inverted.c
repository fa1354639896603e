/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/inverted.h"

#include <math.h>

#include "models/common/grasp.h"
#include "rt/hash.h"
#include "rt/vec.h"

/* s, in which every tetrahedron is looked at. */
#define ROUND 0.1
/* Tetrahedra a step, however short the step: half a microsecond. */
enum { LEAST_SHARE = 32 };

/* Differences of places in double precision, of displacements as they are stored: nothing cancels
 * far from the origin. */
static bool is_inside_out(const ss_mesh *mesh, int32_t t, const ss_real *u)
{
    const int32_t *c = mesh->tetrahedron[t];
    const ss_real *u0 = u + 4 * (ptrdiff_t)c[0];
    double side[3][3], n[3];
    for (int a = 0; a < 3; ++a) {
        const ss_real *own = u + 4 * (ptrdiff_t)c[a + 1];
        for (int k = 0; k < 3; ++k) {
            side[a][k] =
                mesh->position[c[a + 1]][k] - mesh->position[c[0]][k] + (double)(own[k] - u0[k]);
        }
    }
    ss_cross3(n, side[0], side[1]);
    return !(ss_dot3(n, side[2]) > 0.0);
}

void ss_inverted_init(ss_inverted *inverted, const ss_mesh *mesh, double step)
{
    const double share = ceil(mesh->tetrahedron_count * fmin(1.0, step / ROUND));
    *inverted = (ss_inverted){.mesh = mesh, .share = (int32_t)fmax(share, LEAST_SHARE)};
    if (inverted->share > mesh->tetrahedron_count) {
        inverted->share = mesh->tetrahedron_count;
    }
    ss_inverted_reset(inverted);
}

void ss_inverted_reset(ss_inverted *inverted)
{
    inverted->at = inverted->clean = 0;
    inverted->found = -1;
}

void ss_inverted_pass(ss_inverted *inverted)
{
    const int32_t count = inverted->mesh->tetrahedron_count;
    inverted->at = count > 0 ? (inverted->at + inverted->share) % count : 0;
    inverted->clean = 0;
    inverted->found = -1;
}

int32_t ss_inverted_look(ss_inverted *inverted, const ss_real *u)
{
    const ss_mesh *mesh = inverted->mesh;
    bool is_any = inverted->found >= 0 && is_inside_out(mesh, inverted->found, u);
    inverted->clean += inverted->share;
    for (int32_t k = 0; k < inverted->share; ++k) {
        const int32_t t = inverted->at++;
        inverted->at = inverted->at < mesh->tetrahedron_count ? inverted->at : 0;
        if (is_inside_out(mesh, t, u)) {
            inverted->found = is_any ? inverted->found : t;
            is_any = true;
        }
    }
    inverted->clean = is_any ? 0 : inverted->clean;
    if (inverted->clean >= mesh->tetrahedron_count) {
        inverted->clean = 0;
        inverted->found = -1;
    }
    return inverted->found;
}

uint64_t ss_inverted_hash(const ss_inverted *inverted, uint64_t seed)
{
    const int32_t state[3] = {inverted->at, inverted->found, inverted->clean};
    return inverted->found < 0 ? seed : ss_hash_bytes(seed, state, sizeof state);
}
