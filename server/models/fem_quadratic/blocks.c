/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_quadratic/quadratic.h"
/*
 * Elements into blocks of eight: straight ones first, 40 bytes of geometry each, then curved ones,
 * 160. As in common/fem_blocks.c they are dealt like cards, so that the eight of a block share no
 * node where that can be: forces are added node by node, and a store that is loaded again at once
 * stalls.
 */
#include <math.h>
#include <string.h>

#include "mesh/tetrahedron.h"
#include "rt/memory.h"

/* Blocks of a run. */
enum { DEAL = 32 };
enum { CURVED = SS_FEM_SHAPES + 1 };

static bool is_straight(const ss_mesh *mesh, const int32_t node[SS_QUADRATIC_NODES])
{
    double longest = 0.0, off = 0.0;
    for (int k = 0; k < 4; ++k) {
        for (int j = k + 1; j < 4; ++j) {
            const double *a = mesh->position[node[k]], *b = mesh->position[node[j]];
            const double *m = mesh->position[node[ss_tetrahedron_place(k, j)]];
            double d[3], bend[3];
            for (int i = 0; i < 3; ++i) {
                d[i] = b[i] - a[i];
                bend[i] = m[i] - 0.5 * (a[i] + b[i]);
            }
            longest = fmax(longest, ss_norm3(d));
            off = fmax(off, ss_norm3(bend));
        }
    }
    return off <= SS_QUADRATIC_STRAIGHT * longest;
}

bool ss_quadratic_points(const ss_mesh *mesh, const int32_t node[SS_QUADRATIC_NODES],
                         ss_quadratic_point out[SS_QUADRATIC_POINTS])
{
    for (int q = 0; q < SS_QUADRATIC_POINTS; ++q) {
        out[q].volume =
            ss_tetrahedron_point((const double(*)[3])mesh->position, node, q, out[q].gradient);
    }
    return is_straight(mesh, node);
}

void ss_quadratic_shape(const ss_quadratic_point *point, int q, double out[SS_QUADRATIC_NODES][3])
{
    for (int k = 0; k < 4; ++k) {
        const double lk = k == q ? SS_TETRAHEDRON_NEAR : SS_TETRAHEDRON_FAR;
        for (int i = 0; i < 3; ++i) {
            out[k][i] = (4.0 * lk - 1.0) * point->gradient[k][i];
        }
        for (int j = k + 1; j < 4; ++j) {
            const double lj = j == q ? SS_TETRAHEDRON_NEAR : SS_TETRAHEDRON_FAR;
            for (int i = 0; i < 3; ++i) {
                out[ss_tetrahedron_place(k, j)][i] =
                    4.0 * (lj * point->gradient[k][i] + lk * point->gradient[j][i]);
            }
        }
    }
}

/* ---- blocks ---- */

typedef struct source {
    const ss_quadratic_raised *raised;
    const ss_fem_material *material;
    ss_quadratic_blocks *blocks;
} source;

/* Element e into lane `lane` of block `b`. */
static void fill(const source *from, int32_t e, ptrdiff_t b, int lane)
{
    const ss_fem_material *material = from->material;
    ss_quadratic_blocks *blocks = from->blocks;
    const int32_t *node = from->raised->node[e];
    ss_quadratic_point point[SS_QUADRATIC_POINTS];
    double volume = 0.0;
    (void)ss_quadratic_points(&from->raised->mesh, node, point);
    for (int q = 0; q < SS_QUADRATIC_POINTS; ++q) {
        volume += point[q].volume;
    }
    for (int n = 0; n < SS_QUADRATIC_NODES; ++n) {
        blocks->node[(b * SS_QUADRATIC_NODES + n) * SS_FEM_LANES + lane] = 4 * node[n];
    }
    const bool is_curved = b >= blocks->straight_count;
    for (int q = 0; q < (is_curved ? SS_QUADRATIC_POINTS : 1); ++q) {
        ss_real *shape =
            is_curved ? blocks->curved + (((b - blocks->straight_count) * SS_QUADRATIC_POINTS + q) *
                                          CURVED * SS_FEM_LANES)
                      : blocks->shape + b * SS_FEM_SHAPES * SS_FEM_LANES;
        for (int k = 0; k < SS_FEM_SHAPES; ++k) {
            shape[SS_FEM_LANES * k + lane] = (ss_real)point[q].gradient[1 + k / 3][k % 3];
        }
        if (is_curved) {
            shape[SS_FEM_LANES * SS_FEM_SHAPES + lane] = (ss_real)(point[q].volume / volume);
        }
    }
    ss_real *modulus = blocks->modulus + b * SS_QUADRATIC_MODULI * SS_FEM_LANES + lane;
    modulus[2 * SS_FEM_LANES] = (ss_real)(volume * (material->lambda[e] - material->lambda_own[e]));
    const ss_fem_moduli moduli = ss_fem_moduli_of(material);
    ss_fem_put_moduli(&moduli, e, volume, modulus, blocks->kappa + b * SS_FEM_LANES + lane,
                      blocks->viscosity ? blocks->viscosity + b * 2 * SS_FEM_LANES + lane : NULL);
    blocks->element[b * SS_FEM_LANES + lane] = e;
}

/* `count` elements of a list into the blocks from `b0` to `end`. */
static void deal(const source *from, const int32_t *list, int32_t count, int32_t b0, int32_t end)
{
    for (int32_t first = 0; b0 < end; b0 += DEAL) {
        const int32_t run = end - b0 < DEAL ? end - b0 : DEAL;
        for (int32_t k = 0; k < run * SS_FEM_LANES && first + k < count; ++k) {
            fill(from, list[first + k], b0 + k % run, k / run);
        }
        first += run * SS_FEM_LANES;
    }
}

static int32_t blocks_of(int32_t elements)
{
    return (elements + SS_FEM_LANES - 1) / SS_FEM_LANES;
}

static bool reserve(bool is_viscous, ss_arena *arena, ss_quadratic_blocks *out)
{
    const size_t values = (size_t)out->count * SS_FEM_LANES;
    const size_t straight = (size_t)out->straight_count * SS_FEM_LANES;
    SS_ARENA_TAKE(arena, SS_ROOM(values * SS_QUADRATIC_NODES, out->node),
                  SS_ROOM(straight * SS_FEM_SHAPES, out->shape),
                  SS_ROOM((values - straight) * SS_QUADRATIC_POINTS * CURVED, out->curved),
                  SS_ROOM(values * SS_QUADRATIC_MODULI, out->modulus));
    out->viscosity = is_viscous ? ss_arena_get(arena, values * 2, sizeof *out->viscosity) : NULL;
    out->kappa = ss_arena_get(arena, values, sizeof *out->kappa);
    out->light = ss_arena_get(arena, values * SS_QUADRATIC_NODES, sizeof *out->light);
    out->element = ss_arena_get(arena, values, sizeof *out->element);
    if (ss_arena_status(arena) != SOFTSIM_OK) {
        return false;
    }
    memset(out->element, 0xff, values * sizeof *out->element);
    return true;
}

bool ss_quadratic_blocks_create(const ss_quadratic_raised *raised, const ss_fem_material *material,
                                ss_arena *arena, ss_quadratic_blocks *out)
{
    const int32_t elements = raised->mesh.tetrahedron_count;
    int32_t *list = ss_memory_get((size_t)elements, sizeof *list); /* straight, then curved ones */
    int32_t straight = 0, curved = 0;
    if (!list) {
        return false;
    }
    for (int32_t e = 0; e < elements; ++e) {
        straight += is_straight(&raised->mesh, raised->node[e]);
    }
    for (int32_t e = 0, at = 0; e < elements; ++e) {
        const bool is = is_straight(&raised->mesh, raised->node[e]);
        list[is ? at++ : straight + curved++] = e;
    }
    *out = (ss_quadratic_blocks){.count = blocks_of(straight) + blocks_of(curved),
                                 .straight_count = blocks_of(straight),
                                 .element_count = elements,
                                 .node_count = raised->mesh.node_count};
    const bool is_good = reserve(material->phi != NULL, arena, out);
    if (is_good) {
        const source from = {raised, material, out};
        deal(&from, list, straight, 0, out->straight_count);
        deal(&from, list + straight, curved, out->straight_count, out->count);
    }
    ss_memory_free(list);
    return is_good;
}
