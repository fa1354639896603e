/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/xpbd/kernels.h"
/*
 * Tetrahedra into packs of eight that share no node, and which path of the kernels runs.
 *
 * Eight lanes that move the same node at once would move it too far. The elements are taken in the
 * mesh's order, which keeps neighbours near in memory, and each goes into the first open pack that
 * has none of its nodes; a full pack is closed, and so is the oldest where too many are open. Packs
 * follow one another as colours would, but stay in the cache: rejected is a colouring of the whole
 * mesh, each colour of which runs over all of memory.
 */
#include <string.h>

#include "mesh/tetrahedron.h"
#include "models/common/dispatch.h"

enum { OPEN = 48 }; /* packs that wait for elements */

typedef struct open_pack {
    int32_t element[SS_FEM_LANES];
    int32_t count;
} open_pack;

typedef struct packer {
    const int32_t (*corner)[4];
    open_pack open[OPEN];
    int32_t open_count;
    int32_t *packed; /* elements in the order of lanes, -1 spare */
    int32_t pack_count;
} packer;

static bool shares_node(const packer *p, const open_pack *pack, int32_t e)
{
    for (int32_t k = 0; k < pack->count; ++k) {
        const int32_t *a = p->corner[pack->element[k]], *b = p->corner[e];
        for (int i = 0; i < 16; ++i) {
            if (a[i / 4] == b[i % 4]) {
                return true;
            }
        }
    }
    return false;
}

static void close_pack(packer *p, int32_t which)
{
    int32_t *lane = p->packed + (ptrdiff_t)p->pack_count * SS_FEM_LANES;
    for (int k = 0; k < SS_FEM_LANES; ++k) {
        lane[k] = k < p->open[which].count ? p->open[which].element[k] : -1;
    }
    ++p->pack_count;
    --p->open_count;
    memmove(&p->open[which], &p->open[which + 1],
            (size_t)(p->open_count - which) * sizeof *p->open);
}

static void add_element(packer *p, int32_t e)
{
    int32_t which = 0;
    while (which < p->open_count && shares_node(p, &p->open[which], e)) {
        ++which;
    }
    if (which == OPEN) {
        close_pack(p, 0);
        --which;
    }
    open_pack *pack = &p->open[which];
    if (which == p->open_count) {
        pack->count = 0;
        ++p->open_count;
    }
    pack->element[pack->count++] = e;
    if (pack->count == SS_FEM_LANES) {
        close_pack(p, which);
    }
}

/* One element into a lane. */
static void fill(const ss_xpbd_packs *packs, ptrdiff_t b, int lane, const double (*position)[3],
                 const int32_t corner[4], double lambda, double mu, const ss_real *mobility)
{
    double gradient[4][3], spread[6] = {0.0};
    const double volume =
        ss_tetrahedron_gradients(position[corner[0]], position[corner[1]], position[corner[2]],
                                 position[corner[3]], gradient);
    ss_real *shape = packs->shape + b * SS_FEM_SHAPES * SS_FEM_LANES + lane;
    ss_real *modulus = packs->modulus + b * SS_FEM_MODULI * SS_FEM_LANES + lane;
    for (int a = 0; a < 4; ++a) {
        const ss_real *m = mobility + 4 * (ptrdiff_t)corner[a];
        const ss_real most = m[0] > m[1] ? (m[0] > m[2] ? m[0] : m[2]) : m[1] > m[2] ? m[1] : m[2];
        const double w = (double)most;
        packs->node[(b * 4 + a) * SS_FEM_LANES + lane] = 4 * corner[a];
        packs->light[(b * 4 + a) * SS_FEM_LANES + lane] = most;
        for (int k = 0; k < 3; ++k) {
            spread[k] += w * gradient[a][k] * gradient[a][k];
            spread[3 + k] += w * gradient[a][(k + 1) % 3] * gradient[a][(k + 2) % 3];
            packs->is_partial[b] |= (m[k] > 0) != (most > 0);
        }
    }
    for (int k = 0; k < SS_FEM_SHAPES; ++k) {
        shape[SS_FEM_LANES * k] = (ss_real)gradient[1 + k / 3][k % 3];
    }
    for (int k = 0; k < 6; ++k) {
        packs->spread[(b * 6 + k) * SS_FEM_LANES + lane] = (ss_real)spread[k];
    }
    modulus[0] = (ss_real)(volume * lambda);
    modulus[SS_FEM_LANES] = (ss_real)(volume * mu);
}

bool ss_xpbd_packs_create(int32_t element_count, const int32_t (*corner)[4],
                          const double (*position)[3], const double *lambda, const double *mu,
                          const ss_real *mobility, ss_arena *arena, ss_xpbd_packs *out_packs)
{
    *out_packs = (ss_xpbd_packs){.element_count = element_count};
    ss_arena scratch = {0};
    packer *p = ss_arena_get(&scratch, 1, sizeof *p);
    /* At worst every pack has one element. */
    int32_t *packed = ss_arena_get(&scratch, (size_t)element_count * SS_FEM_LANES, sizeof *packed);
    if (!p || !packed) {
        ss_arena_free(&scratch);
        return false;
    }
    p->corner = corner;
    p->packed = packed;
    for (int32_t e = 0; e < element_count; ++e) {
        add_element(p, e);
    }
    while (p->open_count > 0) {
        close_pack(p, 0);
    }
    const int32_t count = p->pack_count;
    const size_t values = (size_t)count * SS_FEM_LANES;
    ss_xpbd_packs packs = {
        .count = count,
        .element_count = element_count,
        .node = ss_arena_get(arena, values * 4, sizeof *packs.node),
        .shape = ss_arena_get(arena, values * SS_FEM_SHAPES, sizeof *packs.shape),
        .modulus = ss_arena_get(arena, values * SS_FEM_MODULI, sizeof *packs.modulus),
        .light = ss_arena_get(arena, values * 4, sizeof *packs.light),
        .spread = ss_arena_get(arena, values * 6, sizeof *packs.spread),
        .is_partial = ss_arena_get(arena, (size_t)count, 1)};
    *out_packs = packs;
    const bool is_good = ss_arena_status(arena) == SOFTSIM_OK;
    for (size_t k = 0; is_good && k < values; ++k) {
        const int32_t e = packed[k];
        if (e >= 0) {
            fill(&packs, (ptrdiff_t)(k / SS_FEM_LANES), (int)(k % SS_FEM_LANES), position,
                 corner[e], lambda[e], mu[e], mobility);
        }
    }
    ss_arena_free(&scratch);
    return is_good;
}

/* ---- the path ---- */

SS_KERNEL_PATHS_512(ss_xpbd_kernels)
