/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/fem_kernels.h"
/*
 * Elements into blocks of eight.
 *
 * The mesh's order keeps neighbours together (ss_mesh_renumber), so eight elements in a row share
 * nodes, and a kernel that adds their forces one by one waits for each store before the next load.
 * Elements are therefore dealt like cards: of each run of 8 x DEAL, lane l of block b gets number
 * l DEAL + b, DEAL elements away from its neighbours in the block and still in the same cache.
 */
#include <stddef.h>

#include "mesh/tetrahedron.h"

/* Blocks of a run. */
enum { DEAL = 32 };

/* One element into lane `lane` of block `b`. */
static void fill(const ss_fem_stuff *stuff, ss_fem_blocks *blocks, int32_t e, ptrdiff_t b, int lane)
{
    const ss_mesh *mesh = stuff->mesh;
    const int32_t *corner = mesh->tetrahedron[e];
    double gradient[4][3];
    double volume =
        ss_tetrahedron_gradients(mesh->position[corner[0]], mesh->position[corner[1]],
                                 mesh->position[corner[2]], mesh->position[corner[3]], gradient);
    volume *= stuff->volume_share ? stuff->volume_share[e] : 1.0;
    ss_real *shape = blocks->shape + b * SS_FEM_SHAPES * SS_FEM_LANES + lane;
    ss_real *modulus = blocks->modulus + b * SS_FEM_MODULI * SS_FEM_LANES + lane;
    for (int a = 0; a < 4; ++a) {
        blocks->node[(b * 4 + a) * SS_FEM_LANES + lane] = 4 * corner[a];
    }
    for (int k = 0; k < SS_FEM_SHAPES; ++k) {
        shape[SS_FEM_LANES * k] = (ss_real)gradient[1 + k / 3][k % 3];
    }
    ss_fem_put_moduli(&stuff->moduli, e, volume, modulus, blocks->kappa + b * SS_FEM_LANES + lane,
                      blocks->viscosity ? blocks->viscosity + b * 2 * SS_FEM_LANES + lane : NULL);
    blocks->volume[b * SS_FEM_LANES + lane] =
        stuff->moduli.lambda[e] > stuff->moduli.lambda_own[e] ? (ss_real)volume : 0;
    blocks->element[b * SS_FEM_LANES + lane] = e;
}

bool ss_fem_blocks_reserve(int32_t element_count, int32_t node_count, bool is_viscous,
                           ss_arena *arena, ss_fem_blocks *out_blocks)
{
    const size_t count = ((size_t)element_count + SS_FEM_LANES - 1) / SS_FEM_LANES;
    const size_t values = count * SS_FEM_LANES;
    const ss_fem_blocks blocks = {
        .count = (int32_t)count,
        .element_count = element_count,
        .node_count = node_count,
        .node = ss_arena_get(arena, values * 4, sizeof *blocks.node),
        .shape = ss_arena_get(arena, values * SS_FEM_SHAPES, sizeof *blocks.shape),
        .modulus = ss_arena_get(arena, values * SS_FEM_MODULI, sizeof *blocks.modulus),
        .viscosity = is_viscous ? ss_arena_get(arena, values * 2, sizeof *blocks.viscosity) : NULL,
        .kappa = ss_arena_get(arena, values, sizeof *blocks.kappa),
        .volume = ss_arena_get(arena, values, sizeof *blocks.volume),
        .element = ss_arena_get(arena, values, sizeof *blocks.element)};
    *out_blocks = blocks;
    for (size_t k = 0; blocks.element != NULL && k < values; ++k) {
        blocks.element[k] = -1;
    }
    return ss_arena_status(arena) == SOFTSIM_OK;
}

bool ss_fem_blocks_create(const ss_fem_stuff *stuff, ss_arena *arena, ss_fem_blocks *out_blocks)
{
    const int32_t elements = stuff->mesh->tetrahedron_count;
    if (!ss_fem_blocks_reserve(elements, stuff->node_count, stuff->moduli.phi != NULL, arena,
                               out_blocks)) {
        return false;
    }
    const int32_t count = out_blocks->count;
    for (int32_t first = 0, b0 = 0; b0 < count; b0 += DEAL) {
        const int32_t deal = count - b0 < DEAL ? count - b0 : DEAL;
        for (int32_t k = 0; k < deal * SS_FEM_LANES && first + k < elements; ++k) {
            fill(stuff, out_blocks, first + k, b0 + k % deal, k / deal);
        }
        first += deal * SS_FEM_LANES;
    }
    return true;
}
