/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/turned.h"

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

void ss_turned_init(ss_turned *turned, const ss_mesh *mesh, double step)
{
    const double share = ceil(mesh->tetrahedron_count * fmin(1.0, step / ROUND));
    *turned = (ss_turned){.mesh = mesh, .share = (int32_t)fmax(share, LEAST_SHARE)};
    if (turned->share > mesh->tetrahedron_count) {
        turned->share = mesh->tetrahedron_count;
    }
    ss_turned_reset(turned);
}

void ss_turned_reset(ss_turned *turned)
{
    turned->at = turned->clean = 0;
    turned->found = -1;
}

void ss_turned_pass(ss_turned *turned)
{
    const int32_t count = turned->mesh->tetrahedron_count;
    turned->at = count > 0 ? (turned->at + turned->share) % count : 0;
    turned->clean = 0;
    turned->found = -1;
}

int32_t ss_turned_look(ss_turned *turned, const ss_real *u)
{
    const ss_mesh *mesh = turned->mesh;
    bool is_any = turned->found >= 0 && is_inside_out(mesh, turned->found, u);
    turned->clean += turned->share;
    for (int32_t k = 0; k < turned->share; ++k) {
        const int32_t t = turned->at++;
        turned->at = turned->at < mesh->tetrahedron_count ? turned->at : 0;
        if (is_inside_out(mesh, t, u)) {
            turned->found = is_any ? turned->found : t;
            is_any = true;
        }
    }
    turned->clean = is_any ? 0 : turned->clean;
    if (turned->clean >= mesh->tetrahedron_count) {
        turned->clean = 0;
        turned->found = -1;
    }
    return turned->found;
}

uint64_t ss_turned_hash(const ss_turned *turned, uint64_t seed)
{
    const int32_t state[3] = {turned->at, turned->found, turned->clean};
    return turned->found < 0 ? seed : ss_hash_bytes(seed, state, sizeof state);
}
