/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * Tetrahedra that links alone would let turn inside out.
 *
 * A chain knows lengths, no volumes: a cell pushed through the face opposite shortens its links by
 * no more than 40 %. Once a step every tetrahedron with V < V0/5 is put back to that volume by the
 * least motion of its corners that may move, u_i += (V0/5 - V) w_i dV/dP_i / sum w |dV/dP|^2, one
 * after the other in their order. What that changes of W is work: a support that moves. Looking
 * costs 15 us for 20,000 tetrahedra, eight at a time.
 *
 * Putting back stretches links, so W can rise. While something is moved that is paid for by it.
 * While every contact is held the step as a whole must not raise W: it is shortened by halves, back
 * towards where it began, where no tetrahedron was low either (step.c): a projected descent
 * with a line search. Rejected: taking back the guard's motion alone, which leaves tetrahedra
 * inverted that links want so; a barrier in W, whose stiffness shortens every step for the few
 * tetrahedra that ever need it.
 */
#include <math.h>
#include <string.h>

#include "rt/vec.h"

/* Of the volume at rest. */
#define LEAST_SHARE 0.2

struct ss_chain_guard {
    ss_chain_tets tets;
    ss_real *rest, *place; /* quads about the body's first node, at rest and now */
    ss_real *before;       /* displacements as the step began */
    int32_t *low;          /* tetrahedra to put back */
};

static double volume6(double p[4][3])
{
    double a[3], b[3], c[3], n[3];
    ss_sub3(a, p[1], p[0]);
    ss_sub3(b, p[2], p[0]);
    ss_sub3(c, p[3], p[0]);
    ss_cross3(n, b, c);
    return ss_dot3(a, n);
}

static void set_groups(ss_chain_guard *guard, const ss_mesh *mesh)
{
    ss_chain_tets *tets = &guard->tets;
    for (int32_t t = 0; t < tets->group_count * SS_CHAIN_LANES; ++t) {
        ss_chain_tet_group *group = &tets->group[t / SS_CHAIN_LANES];
        const int lane = t % SS_CHAIN_LANES;
        if (t >= mesh->tetrahedron_count) { /* four times the same node, never below its limit */
            group->limit[lane] = -1;
            continue;
        }
        double p[4][3];
        for (int k = 0; k < 4; ++k) {
            const int32_t node = mesh->tetrahedron[t][k];
            group->corner[k][lane] = 4 * node;
            ss_copy3(p[k], mesh->position[node]);
        }
        group->limit[lane] = (ss_real)(LEAST_SHARE * volume6(p));
    }
}

softsim_status ss_chain_guard_create(ss_model *model)
{
    const ss_mesh *mesh = model->plan.mesh;
    ss_arena *arena = &model->arena;
    ss_chain_guard *guard = ss_arena_get(arena, 1, sizeof *guard);
    model->guard = guard;
    if (!guard) {
        return SOFTSIM_ERROR_MEMORY;
    }
    const size_t n = (size_t)model->padded, tets = (size_t)mesh->tetrahedron_count;
    guard->tets.group_count = (mesh->tetrahedron_count + SS_CHAIN_LANES - 1) / SS_CHAIN_LANES;
    SS_ARENA_TAKE(arena, SS_ROOM((size_t)guard->tets.group_count, guard->tets.group),
                  SS_ROOM(4 * n, guard->rest), SS_ROOM(4 * n, guard->place),
                  SS_ROOM(4 * n, guard->before), SS_ROOM(tets, guard->low));
    if (ss_arena_status(arena) != SOFTSIM_OK) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            guard->rest[4 * (ptrdiff_t)i + k] =
                (ss_real)(mesh->position[i][k] - mesh->position[0][k]);
        }
    }
    set_groups(guard, mesh);
    return SOFTSIM_OK;
}

static void place_corners(const ss_model *model, const int32_t corner[4], double p[4][3])
{
    const ss_mesh *mesh = model->plan.mesh;
    for (int k = 0; k < 4; ++k) {
        for (int a = 0; a < 3; ++a) {
            p[k][a] = mesh->position[corner[k]][a] + (double)model->u[4 * (ptrdiff_t)corner[k] + a];
        }
    }
}

/* Puts one tetrahedron back to a fifth; returns its volume over that at rest afterwards. */
static double put_back(ss_model *model, int32_t t)
{
    static const int8_t face[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
    const ss_mesh *mesh = model->plan.mesh;
    const int32_t *corner = mesh->tetrahedron[t];
    double rest[4][3], p[4][3], slope[4][3], square = 0.0;
    for (int k = 0; k < 4; ++k) {
        ss_copy3(rest[k], mesh->position[corner[k]]);
    }
    place_corners(model, corner, p);
    const double volume = volume6(rest), missing = LEAST_SHARE * volume - volume6(p);
    if (!(missing > 0.0)) {
        return LEAST_SHARE;
    }
    for (int k = 0; k < 4; ++k) { /* d(6V)/dP: twice the area vector of the face opposite */
        double along[3], across[3];
        const bool is_held = model->is_touched && model->is_touched[corner[k]];
        ss_sub3(along, p[face[k][1]], p[face[k][0]]);
        ss_sub3(across, p[face[k][2]], p[face[k][0]]);
        ss_cross3(slope[k], along, across);
        for (int a = 0; a < 3; ++a) {
            const bool is_free = !is_held && model->free[4 * (ptrdiff_t)corner[k] + a] > 0;
            slope[k][a] = is_free ? slope[k][a] : 0.0;
        }
        square += ss_dot3(slope[k], slope[k]);
    }
    /* a body of links as short as these moves by no more than one of them */
    const double most = model->net->mean_length;
    const double before = ss_chain_energy_around(model, 4, corner);
    for (int k = 0; square > 0.0 && k < 4; ++k) {
        double by[3];
        ss_scale3(by, slope[k], missing / square);
        const double length = ss_norm3(by);
        for (int a = 0; a < 3; ++a) {
            model->u[4 * (ptrdiff_t)corner[k] + a] +=
                (ss_real)(length > most ? by[a] * most / length : by[a]);
        }
        ss_chain_wake(model, corner[k]);
    }
    model->work += ss_chain_energy_around(model, 4, corner) - before;
    place_corners(model, corner, p);
    return volume6(p) / volume;
}

void ss_chain_guard_begin(ss_model *model)
{
    memcpy(model->guard->before, model->u,
           4 * (size_t)model->node_count * sizeof *model->guard->before);
}

void ss_chain_guard_step(ss_model *model)
{
    ss_chain_guard *guard = model->guard;
    const ptrdiff_t end = 4 * (ptrdiff_t)model->node_count;
    for (ptrdiff_t at = 0; at < end; ++at) {
        guard->place[at] = guard->rest[at] + model->u[at];
    }
    const int32_t count = model->kernels->collapse(&guard->tets, guard->place, guard->low);
    model->guarded = count;
    model->worst_element = -1;
    double worst = 0.0;
    for (int32_t k = 0; k < count; ++k) {
        const double share = put_back(model, guard->low[k]);
        if (share <= worst) {
            worst = share;
            model->worst_element = model->plan.mesh->tetrahedron[guard->low[k]][0];
        }
    }
    if (count > 0) {
        ss_chain_tell(model, SOFTSIM_VERDICT_GUARDED,
                      "tetrahedra are kept from turning inside out");
    }
}

void ss_chain_guard_withdraw(ss_model *model, double share)
{
    const ss_real *before = model->guard->before, part = (ss_real)share;
    const ptrdiff_t end = 4 * (ptrdiff_t)model->node_count;
    for (ptrdiff_t at = 0; at < end; ++at) {
        model->u[at] -= part * (model->u[at] - before[at]);
    }
}
