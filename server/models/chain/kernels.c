/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/kernels.h"
/*
 * The kernels, written once. This file is compiled for the baseline processor as it stands, and
 * once more for AVX2 with 256-bit vectors and fused multiply-add.
 *
 *   d = P_b - P_a,  u = |d|,  ex = max(u - lmax, 0) - max(lmin - u, 0)
 *   g = w/2 ex d/u;  dP_a += g, dP_b -= g            (Zhang et al. 2018, equations 7 to 13)
 *   lmax = (1 + r alpha) l0,  lmin = max((1 - r alpha) l0, 0)
 *
 * d is the rest vector plus the difference of displacements, so that no digits are lost far from
 * the origin; ex is bounded as u goes to 0, where the paper's mu = ex/u is not. A group whose
 * squared lengths are all within the squared band is left before the root and the additions, which
 * are two thirds of the work.
 */
#include <stdbool.h>
#include <string.h>

#include "models/common/wide.h"

/* Pairs of nodes, or groups, summed in ss_real before a sum goes over to double. */
enum { BLOCK = 32 };

/* ---- links ---- */

/* Eight links as they lie now. */
typedef struct band {
    ss_pair x, y, z, square, high, low;
} band;

/* True when a link of the group is out of its band. */
SS_INLINE bool find(const ss_chain_group *group, ss_pair ratio, const ss_real *u, band *out)
{
    ss_pair d[4];
    for (int k = 0; k < 4; ++k) {
        const ss_pair a = ss_pair_join(u + group->a[k], u + group->a[k + 4]);
        const ss_pair b = ss_pair_join(u + group->b[k], u + group->b[k + 4]);
        d[k] = ss_pair_sub(b, a);
    }
    ss_pair_transpose(&d[0], &d[1], &d[2], &d[3]);
    out->x = ss_pair_add(d[0], ss_pair_load(group->x));
    out->y = ss_pair_add(d[1], ss_pair_load(group->y));
    out->z = ss_pair_add(d[2], ss_pair_load(group->z));
    out->square =
        ss_pair_fma(out->z, out->z, ss_pair_fma(out->y, out->y, ss_pair_mul(out->x, out->x)));
    const ss_pair rest = ss_pair_load(group->rest);
    const ss_pair slack = ss_pair_mul(ratio, ss_pair_load(group->slack));
    out->high = ss_pair_add(rest, slack);
    out->low = ss_pair_most(ss_pair_sub(rest, slack), ss_pair_all(0));
    return ss_pair_is_any_above(out->square, ss_pair_mul(out->high, out->high)) |
           ss_pair_is_any_above(ss_pair_mul(out->low, out->low), out->square);
}

/* Links whose ends coincide pull along their rest direction. Kept out of the way: it is rare. */
static __attribute__((noinline)) void part_coincident(const ss_chain_group *group, band *now,
                                                      ss_pair *root)
{
    _Alignas(64) ss_real x[4][SS_CHAIN_LANES];
    ss_pair *const value[4] = {&now->x, &now->y, &now->z, root};
    for (int k = 0; k < 4; ++k) {
        ss_pair_store(x[k], *value[k]);
    }
    for (int k = 0; k < SS_CHAIN_LANES; ++k) {
        if (!(x[3][k] > (ss_real)1e-9 * group->rest[k])) {
            /* of length 1e-9 l0: n and ex are exact to rounding */
            x[0][k] = (ss_real)1e-9 * group->x[k];
            x[1][k] = (ss_real)1e-9 * group->y[k];
            x[2][k] = (ss_real)1e-9 * group->z[k];
            x[3][k] = (ss_real)1e-9 * group->rest[k];
        }
    }
    for (int k = 0; k < 4; ++k) {
        *value[k] = ss_pair_load(x[k]);
    }
}

/* half ex / u of each link in *out_factor; returns sum += half ex^2. */
SS_INLINE ss_pair judge(const ss_chain_group *group, band *now, ss_pair *out_factor, ss_pair sum)
{
    ss_pair root = ss_pair_root(now->square);
    const ss_pair tiny = ss_pair_mul(ss_pair_all((ss_real)1e-9), ss_pair_load(group->rest));
    if (__builtin_expect(ss_pair_is_any_above(tiny, root), 0)) {
        part_coincident(group, now, &root);
    }
    const ss_pair zero = ss_pair_all(0);
    const ss_pair ex = ss_pair_sub(ss_pair_most(ss_pair_sub(root, now->high), zero),
                                   ss_pair_most(ss_pair_sub(now->low, root), zero));
    const ss_pair tension = ss_pair_mul(ss_pair_load(group->half), ex);
    *out_factor = ss_pair_div(tension, root);
    return ss_pair_fma(tension, ex, sum);
}

SS_INLINE void add(ss_real *pull, int32_t at, ss_quad g)
{
    ss_quad_store(pull + at, ss_quad_add(ss_quad_load(pull + at), g));
}

SS_INLINE void take(ss_real *pull, int32_t at, ss_quad g)
{
    ss_quad_store(pull + at, ss_quad_sub(ss_quad_load(pull + at), g));
}

SS_INLINE ss_pair pull_group(const ss_chain_group *group, band *now, ss_real *pull, ss_pair sum)
{
    ss_pair factor;
    sum = judge(group, now, &factor, sum);
    ss_pair g[4] = {ss_pair_mul(factor, now->x), ss_pair_mul(factor, now->y),
                    ss_pair_mul(factor, now->z), ss_pair_all(0)};
    ss_pair_transpose(&g[0], &g[1], &g[2], &g[3]);
    for (int k = 0; k < 4; ++k) {
        add(pull, group->a[k], ss_pair_first(g[k]));
        take(pull, group->b[k], ss_pair_first(g[k]));
    }
    for (int k = 0; k < 4; ++k) {
        add(pull, group->a[k + 4], ss_pair_second(g[k]));
        take(pull, group->b[k + 4], ss_pair_second(g[k]));
    }
    return sum;
}

static double pull_all(const ss_chain_net *net, ss_real ratio, const ss_real *u, ss_real *pull)
{
    const ss_pair share = ss_pair_all(ratio);
    double energy = 0.0;
    for (int32_t first = 0; first < net->group_count; first += BLOCK) {
        const int32_t end = first + BLOCK < net->group_count ? first + BLOCK : net->group_count;
        ss_pair sum = ss_pair_all(0);
        for (int32_t g = first; g < end; ++g) {
            band now;
            if (find(&net->group[g], share, u, &now)) {
                sum = pull_group(&net->group[g], &now, pull, sum);
            }
        }
        energy += ss_pair_sum(sum);
    }
    return 0.5 * energy;
}

static double measure(const ss_chain_net *net, ss_real ratio, const ss_real *u)
{
    const ss_pair share = ss_pair_all(ratio);
    double energy = 0.0;
    for (int32_t g = 0; g < net->group_count; ++g) {
        band now;
        if (find(&net->group[g], share, u, &now)) {
            ss_pair factor;
            energy += ss_pair_sum(judge(&net->group[g], &now, &factor, ss_pair_all(0)));
        }
    }
    return 0.5 * energy;
}

/* ---- the front ---- */

/* The lowest number of the set, taken out; -1 when it is empty. *from is where to look on. */
SS_INLINE int32_t take_next(ss_chain_set *set, int32_t *from)
{
    for (int32_t top = *from; top < set->top_count; ++top) {
        const uint64_t words = set->word[top];
        if (words != 0) {
            const int32_t at = 64 * top + __builtin_ctzll(words);
            const uint64_t bits = set->bit[at];
            set->bit[at] = bits & (bits - 1);
            if (set->bit[at] == 0) {
                set->word[top] = words & (words - 1);
            }
            *from = top;
            return 64 * at + __builtin_ctzll(bits);
        }
    }
    *from = set->top_count;
    return -1;
}

static double pull_front(const ss_chain_net *net, ss_real ratio, const ss_real *u, ss_real *pull,
                         ss_chain_front *front)
{
    const ss_pair share = ss_pair_all(ratio);
    double energy = 0.0;
    int32_t from = 0, count = 0;
    ss_pair sum = ss_pair_all(0);
    for (int32_t g = take_next(&front->awake, &from); g >= 0; g = take_next(&front->awake, &from)) {
        const ss_chain_group *group = &net->group[g];
        band now;
        ++front->groups;
        if (!find(group, share, u, &now)) {
            continue;
        }
        sum = pull_group(group, &now, pull, sum);
        ss_chain_set_add(&front->next, g);
        for (int k = 0; k < SS_CHAIN_LANES; ++k) {
            ss_chain_set_add(&front->moving, group->a[k] / 4);
            ss_chain_set_add(&front->moving, group->b[k] / 4);
        }
        if (++count % BLOCK == 0) {
            energy += ss_pair_sum(sum);
            sum = ss_pair_all(0);
        }
    }
    return 0.5 * (energy + ss_pair_sum(sum));
}

/* The largest of the three lanes. */
SS_INLINE double most_of(ss_quad a)
{
    _Alignas(32) ss_real lane[4];
    ss_quad_store(lane, a);
    const double most = (double)(lane[0] > lane[1] ? lane[0] : lane[1]);
    return most > (double)lane[2] ? most : (double)lane[2];
}

/* Of u - u: 0, but NaN where u is not finite, which comparisons would not show. */
SS_INLINE double sum_of(ss_quad a)
{
    _Alignas(32) ss_real lane[4];
    ss_quad_store(lane, a);
    return (double)(lane[0] + lane[1] + lane[2]);
}

static void move_front(const ss_chain_net *net, ss_chain_front *front, ss_chain_motion *motion)
{
    const ss_quad leak = ss_quad_all(motion->leak), zero = ss_quad_all(0);
    const ss_quad h = ss_quad_all(motion->h);
    ss_quad largest = zero, doubt = zero;
    int32_t from = 0;
    for (int32_t i = take_next(&front->moving, &from); i >= 0;
         i = take_next(&front->moving, &from)) {
        const ptrdiff_t at = 4 * (ptrdiff_t)i;
        ss_quad u = ss_quad_load(motion->u + at);
        const ss_quad pulled = ss_quad_fnma(leak, u, ss_quad_load(motion->pull + at));
        const ss_quad step =
            ss_quad_mul(ss_quad_mul(h, ss_quad_load(motion->mobility + at)), pulled);
        u = ss_quad_add(u, step);
        largest = ss_quad_most(ss_quad_most(u, ss_quad_sub(zero, u)), largest);
        doubt = ss_quad_add(doubt, ss_quad_sub(u, u));
        ss_quad_store(motion->u + at, u);
        ss_quad_store(motion->pull + at, zero);
        if (ss_quad_is_any_above(ss_quad_most(step, ss_quad_sub(zero, step)), zero)) {
            ++front->nodes;
            for (int32_t k = net->first[i]; i < net->node_count && k < net->first[i + 1]; ++k) {
                ss_chain_set_add(&front->next, net->at[k] / SS_CHAIN_LANES);
            }
            if (motion->leak > 0) {
                ss_chain_set_add(&front->stay, i);
            }
        }
    }
    motion->largest = most_of(largest) + sum_of(doubt);
}

/* ---- nodes ---- */

static void move(int32_t count, ss_chain_motion *motion)
{
    const ss_pair leak = ss_pair_all(motion->leak), zero = ss_pair_all(0);
    const ss_pair h = ss_pair_all(motion->h);
    const ptrdiff_t end = 4 * (ptrdiff_t)count;
    ss_pair largest = zero, doubt = zero;
    for (ptrdiff_t at = 0; at < end; at += 8) {
        ss_pair u = ss_pair_load(motion->u + at);
        const ss_pair pulled = ss_pair_fnma(leak, u, ss_pair_load(motion->pull + at));
        u = ss_pair_add(u,
                        ss_pair_mul(ss_pair_mul(h, ss_pair_load(motion->mobility + at)), pulled));
        largest = ss_pair_most(ss_pair_most(u, ss_pair_sub(zero, u)), largest);
        doubt = ss_pair_add(doubt, ss_pair_sub(u, u));
        ss_pair_store(motion->u + at, u);
        ss_pair_store(motion->pull + at, zero);
    }
    motion->largest = most_of(ss_pair_fold(largest)) + ss_pair_sum(doubt);
}

/* ---- the coarse level ---- */

/* Sums of a block: of a quad, and of it times x, y, z. In two parts, so that no sum waits for the
 * one before. */
typedef struct moments {
    ss_quad sum[2], x[2], y[2], z[2];
} moments;

static const moments no_moments;

SS_INLINE void join_moments(moments *m)
{
    m->sum[0] = ss_quad_add(m->sum[0], m->sum[1]);
    m->x[0] = ss_quad_add(m->x[0], m->x[1]);
    m->y[0] = ss_quad_add(m->y[0], m->y[1]);
    m->z[0] = ss_quad_add(m->z[0], m->z[1]);
}

/* A block's moments of the pull about its middle, then its cells: a
 * quarter of the multiplications by node and cell. */
static void gather(const ss_chain_hats *hats, const ss_real *pull, ss_real *out_cell)
{
    memset(out_cell, 0, 4 * (size_t)hats->cell_count * sizeof *out_cell);
    for (int32_t block = 0; block < hats->block_count; ++block) {
        const int32_t *node = hats->taking_part + (ptrdiff_t)hats->block * block;
        const ss_real *place = hats->place + (ptrdiff_t)3 * hats->block * block;
        moments m = no_moments;
        for (int i = 0; i < hats->block; i += 2) {
            for (int k = 0; k < 2; ++k) {
                const ss_quad g = ss_quad_load(pull + node[i + k]);
                const ss_real *r = place + 3 * (ptrdiff_t)(i + k);
                m.sum[k] = ss_quad_add(m.sum[k], g);
                m.x[k] = ss_quad_fma(ss_quad_all(r[0]), g, m.x[k]);
                m.y[k] = ss_quad_fma(ss_quad_all(r[1]), g, m.y[k]);
                m.z[k] = ss_quad_fma(ss_quad_all(r[2]), g, m.z[k]);
            }
        }
        join_moments(&m);
        for (int32_t e = hats->first[block]; e < hats->first[block + 1]; ++e) {
            const ss_real *c = hats->linear + (ptrdiff_t)4 * e;
            const ss_quad one =
                ss_quad_fma(ss_quad_all(c[0]), m.sum[0], ss_quad_mul(ss_quad_all(c[1]), m.x[0]));
            const ss_quad two =
                ss_quad_fma(ss_quad_all(c[2]), m.y[0], ss_quad_mul(ss_quad_all(c[3]), m.z[0]));
            ss_real *out = out_cell + hats->cell[e];
            ss_quad_store(out, ss_quad_add(ss_quad_load(out), ss_quad_add(one, two)));
        }
    }
}

static void apply(int32_t count, const ss_real *matrix, const ss_real *cell, ss_real *out)
{
    for (int32_t i = 0; i < count; ++i) {
        const ss_real *row = matrix + (ptrdiff_t)count * i;
        ss_quad sum[4] = {ss_quad_all(0), ss_quad_all(0), ss_quad_all(0), ss_quad_all(0)};
        for (int32_t k = 0; k < count; k += 4) { /* four sums: none waits for the one before */
            for (int m = 0; m < 4; ++m) {
                sum[m] = ss_quad_fma(ss_quad_all(row[k + m]),
                                     ss_quad_load(cell + 4 * (ptrdiff_t)(k + m)), sum[m]);
            }
        }
        ss_quad_store(out + 4 * (ptrdiff_t)i,
                      ss_quad_add(ss_quad_add(sum[0], sum[1]), ss_quad_add(sum[2], sum[3])));
    }
}

static void spread(const ss_chain_hats *hats, const ss_real *mask, const ss_real *cell,
                   ss_real scale, ss_real *u)
{
    const ss_quad factor = ss_quad_all(scale);
    for (int32_t block = 0; block < hats->block_count; ++block) {
        const int32_t *node = hats->node + (ptrdiff_t)hats->block * block;
        const ss_real *place = hats->place + (ptrdiff_t)3 * hats->block * block;
        const int32_t end = hats->first[block + 1];
        moments m = no_moments;
        for (int32_t e = hats->first[block]; e < end; e += 2) {
            for (int k = 0; k < 2 && e + k < end; ++k) {
                const ss_real *c = hats->linear + (ptrdiff_t)4 * (e + k);
                const ss_quad moved = ss_quad_load(cell + hats->cell[e + k]);
                m.sum[k] = ss_quad_fma(ss_quad_all(c[0]), moved, m.sum[k]);
                m.x[k] = ss_quad_fma(ss_quad_all(c[1]), moved, m.x[k]);
                m.y[k] = ss_quad_fma(ss_quad_all(c[2]), moved, m.y[k]);
                m.z[k] = ss_quad_fma(ss_quad_all(c[3]), moved, m.z[k]);
            }
        }
        join_moments(&m);
        const ss_quad sum = ss_quad_mul(factor, m.sum[0]), x = ss_quad_mul(factor, m.x[0]);
        const ss_quad y = ss_quad_mul(factor, m.y[0]), z = ss_quad_mul(factor, m.z[0]);
        for (int i = 0; i < hats->block; ++i) {
            const ss_real *r = place + 3 * (ptrdiff_t)i;
            const ss_quad moved =
                ss_quad_add(ss_quad_fma(ss_quad_all(r[0]), x, sum),
                            ss_quad_fma(ss_quad_all(r[1]), y, ss_quad_mul(ss_quad_all(r[2]), z)));
            ss_quad_store(u + node[i], ss_quad_fma(ss_quad_load(mask + node[i]), moved,
                                                   ss_quad_load(u + node[i])));
        }
    }
}

/* ---- tetrahedra ---- */

static int32_t collapse(const ss_chain_tets *tets, const ss_real *place, int32_t *out_list)
{
    int32_t count = 0;
    for (int32_t g = 0; g < tets->group_count; ++g) {
        const ss_chain_tet_group *group = &tets->group[g];
        ss_pair edge[3][4];
        for (int k = 0; k < 4; ++k) {
            const ss_pair p =
                ss_pair_join(place + group->corner[0][k], place + group->corner[0][k + 4]);
            for (int e = 0; e < 3; ++e) {
                const int32_t *corner = group->corner[e + 1];
                edge[e][k] = ss_pair_sub(ss_pair_join(place + corner[k], place + corner[k + 4]), p);
            }
        }
        for (int e = 0; e < 3; ++e) {
            ss_pair_transpose(&edge[e][0], &edge[e][1], &edge[e][2], &edge[e][3]);
        }
        const ss_pair *a = edge[0], *b = edge[1], *c = edge[2];
        const ss_pair nx = ss_pair_fnma(b[2], c[1], ss_pair_mul(b[1], c[2]));
        const ss_pair ny = ss_pair_fnma(b[0], c[2], ss_pair_mul(b[2], c[0]));
        const ss_pair nz = ss_pair_fnma(b[1], c[0], ss_pair_mul(b[0], c[1]));
        const ss_pair volume = ss_pair_fma(a[2], nz, ss_pair_fma(a[1], ny, ss_pair_mul(a[0], nx)));
        if (!ss_pair_is_any_above(ss_pair_load(group->limit), volume)) {
            continue;
        }
        _Alignas(64) ss_real six[SS_CHAIN_LANES];
        ss_pair_store(six, volume);
        for (int k = 0; k < SS_CHAIN_LANES; ++k) {
            if (group->limit[k] > six[k]) {
                out_list[count++] = g * SS_CHAIN_LANES + k;
            }
        }
    }
    return count;
}

/* ---- the table ---- */

SS_KERNEL_TABLE(ss_chain_kernels, .pull = pull_all, .measure = measure, .pull_front = pull_front,
                .move = move, .move_front = move_front, .gather = gather, .apply = apply,
                .spread = spread, .collapse = collapse);
