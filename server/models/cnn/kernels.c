/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/kernels.h"
/*
 * The kernels, written once. This file is compiled for the baseline processor as it stands, and
 * once more for AVX2 with 256-bit vectors and fused multiply-add.
 *
 * Where the time goes: the product reads three things an entry (neighbour, kap, u of the
 * neighbour) and is bound by loads, so differences u_i - u_j are free, and they lose no digits
 * where far nodes move together. Node loops stream from L2, two nodes at a time where a register
 * holds them (26 to 18 us a sub-step, 1192 nodes with one loaded), and take N.u of what they write
 * along (19 to 18 us). Rejected: products in edge order
 * (half the bytes, but each edge reads, changes and writes r of both ends), padded rows.
 */
#include <stdbool.h>
#include <stddef.h>

#include "models/common/wide.h"

/* Rows summed in ss_real before a sum goes over to double. */
enum { BLOCK = 32 };

static int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* ---- sparse ---- */

/* One row: r_i = b_i + sum_j kap_ij (u_i - u_j). */
SS_INLINE ss_quad product_row(int32_t degree, const int32_t *neighbour, const ss_real *kap,
                              const ss_real *u, ss_quad ui, ss_quad r)
{
    for (int32_t k = 0; k < degree; ++k) {
        const ss_quad d = ss_quad_sub(ui, ss_quad_load(u + neighbour[k]));
        r = ss_quad_fma(ss_quad_all(kap[k]), d, r);
    }
    return r;
}

SS_INLINE void product_group(const ss_cnn_rows *rows, const ss_cnn_group *group, int32_t degree,
                             const ss_real *kap, const ss_real *b, const ss_real *u, ss_real *r,
                             double *ub, double *ur)
{
    const int32_t *neighbour = rows->neighbour + group->first_entry;
    const int32_t *node = rows->node + group->first_row;
    kap += group->first_entry;
    for (int32_t first = 0; first < group->row_count; first += BLOCK) {
        const int32_t end = least(first + BLOCK, group->row_count);
        ss_quad sum_ub = ss_quad_all(0), sum_ur = ss_quad_all(0);
        for (int32_t row = first; row < end; ++row) {
            const int32_t i = node[row];
            const ss_quad ui = ss_quad_load(u + i);
            const ss_quad bi = b ? ss_quad_load(b + i) : ss_quad_all(0);
            const ss_quad ri = product_row(degree, neighbour, kap, u, ui, bi);
            sum_ub = ss_quad_fma(ui, bi, sum_ub);
            sum_ur = ss_quad_fma(ui, ri, sum_ur);
            ss_quad_store(r + i, ri);
            neighbour += degree;
            kap += degree;
        }
        *ub += ss_quad_sum(sum_ub);
        *ur += ss_quad_sum(sum_ur);
    }
}

SS_INLINE void product_rows(const ss_cnn_rows *rows, const ss_cnn_span *span, const ss_real *kap,
                            const ss_real *b, const ss_real *u, ss_real *r, double *ub, double *ur)
{
    for (int32_t g = span->group; g < span->group_end; ++g) {
        const ss_cnn_group *group = &rows->group[g];
        switch (group->degree) { /* constant degrees unroll */
#define CASE(degree)                                                                               \
    case degree:                                                                                   \
        product_group(rows, group, degree, kap, b, u, r, ub, ur);                                  \
        break
            CASE(4);
            CASE(5);
            CASE(6);
            CASE(7);
            CASE(8);
#undef CASE
        default:
            product_group(rows, group, group->degree, kap, b, u, r, ub, ur);
            break;
        }
    }
}

static void product(const ss_cnn_rows *rows, const ss_cnn_part *part, const ss_real *kap,
                    const ss_real *b, const ss_real *u, ss_real *r, double *out_ub, double *out_ur)
{
    double ub = 0.0, ur = 0.0;
    for (int32_t k = 0; k < part->count; ++k) {
        if (b) {
            product_rows(rows, &part->span[k], kap, b, u, r, &ub, &ur);
        } else {
            product_rows(rows, &part->span[k], kap, NULL, u, r, &ub, &ur);
        }
    }
    *out_ub = ub;
    *out_ur = ur;
}

static void scatter(const ss_cnn_rows *rows, const ss_cnn_part *part, const ss_real *kap_edge,
                    ss_real *kap, ss_real *b)
{
    for (int32_t s = 0; s < part->count; ++s) {
        for (int32_t g = part->span[s].group; g < part->span[s].group_end; ++g) {
            const ss_cnn_group *group = &rows->group[g];
            const int32_t degree = group->degree;
            const int32_t *node = rows->node + group->first_row;
            const int32_t *edge = rows->edge + group->first_entry;
            const ss_real *arm = rows->arm + 4 * (ptrdiff_t)group->first_entry;
            ss_real *out = kap + group->first_entry;
            for (int32_t row = 0; row < group->row_count; ++row) {
                ss_quad bi = ss_quad_all(0);
                for (int32_t k = 0; k < degree; ++k) {
                    const ss_real value = kap_edge[edge[k]];
                    out[k] = value;
                    bi = ss_quad_fma(ss_quad_all(value), ss_quad_load(arm + 4 * k), bi);
                }
                ss_quad_store(b + node[row], bi);
                edge += degree;
                out += degree;
                arm += 4 * (ptrdiff_t)degree;
            }
        }
    }
}

/* ---- edges ---- */

static void strain(const ss_cnn_edges *edges, const ss_real *u, ss_real *out_strain,
                   ss_real *out_stretch)
{
    const ss_quad half = ss_quad_all((ss_real)0.5);
    for (int32_t e = 0; e < edges->padded_count; e += 4) {
        const int32_t *i = edges->from + e, *j = edges->to + e;
        ss_quad x = ss_quad_sub(ss_quad_load(u + j[0]), ss_quad_load(u + i[0]));
        ss_quad y = ss_quad_sub(ss_quad_load(u + j[1]), ss_quad_load(u + i[1]));
        ss_quad z = ss_quad_sub(ss_quad_load(u + j[2]), ss_quad_load(u + i[2]));
        ss_quad w = ss_quad_sub(ss_quad_load(u + j[3]), ss_quad_load(u + i[3]));
        ss_quad_transpose(&x, &y, &z, &w);
        const ss_quad square = ss_quad_fma(x, x, ss_quad_fma(y, y, ss_quad_mul(z, z)));
        const ss_quad stretch = ss_quad_mul(half, square);
        const ss_quad sum =
            ss_quad_fma(ss_quad_load(edges->x + e), x,
                        ss_quad_fma(ss_quad_load(edges->y + e), y,
                                    ss_quad_fma(ss_quad_load(edges->z + e), z, stretch)));
        ss_quad_store(out_stretch + e, stretch);
        ss_quad_store(out_strain + e, sum);
    }
}

/* Up to four columns in one pass: each is read once for the sum, its strain and its stretch. */
SS_INLINE void combine_some(int32_t first, int32_t end, int32_t count, const ss_real *const *column,
                            const double *weight, const ss_real *edge_strain,
                            const ss_real *stretch, ss_real *sum, double *eps, double *eta)
{
    ss_wide total_eps[4], total_eta[4], w[4];
    for (int32_t c = 0; c < count; ++c) {
        total_eps[c] = total_eta[c] = ss_wide_all(0);
        w[c] = ss_wide_all((ss_real)weight[c]);
    }
    for (int32_t e = first; e < end; e += SS_WIDE_LANES) {
        const ss_wide s = ss_wide_load(edge_strain + e), h = ss_wide_load(stretch + e);
        ss_wide total = ss_wide_load(sum + e);
        for (int32_t c = 0; c < count; ++c) {
            const ss_wide kap = ss_wide_load(column[c] + e);
            total = ss_wide_fma(w[c], kap, total);
            total_eps[c] = ss_wide_fma(kap, s, total_eps[c]);
            total_eta[c] = ss_wide_fma(kap, h, total_eta[c]);
        }
        ss_wide_store(sum + e, total);
    }
    for (int32_t c = 0; c < count; ++c) {
        eps[c] += ss_wide_sum(total_eps[c]);
        eta[c] += ss_wide_sum(total_eta[c]);
    }
}

/* Edges in blocks that stay in L1 beside the columns that stream past. */
static void combine(int32_t padded_count, int32_t count, const ss_real *const *column,
                    const double *weight, const ss_real *edge_strain, const ss_real *stretch,
                    ss_real *sum, double *eps, double *eta)
{
    enum { EDGES = 1024 };
    for (int32_t first = 0; first < padded_count; first += EDGES) {
        const int32_t end = least(first + EDGES, padded_count);
        int32_t c = 0;
        for (; c + 4 <= count; c += 4) {
            combine_some(first, end, 4, column + c, weight + c, edge_strain, stretch, sum, eps + c,
                         eta + c);
        }
        for (; c < count; ++c) {
            combine_some(first, end, 1, column + c, weight + c, edge_strain, stretch, sum, eps + c,
                         eta + c);
        }
    }
}

/* ---- nodes ---- */

/* The nodes of a part, BLOCK at a time: start with {.part}. */
typedef struct block_range {
    const ss_cnn_part *part;
    int32_t span, first, end;
} block_range;

SS_INLINE bool next_block(block_range *at)
{
    while (at->span < at->part->count) {
        const ss_cnn_span *span = &at->part->span[at->span];
        at->first = at->end > span->node ? at->end : span->node;
        if (at->first < span->node_end) {
            at->end = least(at->first + BLOCK, span->node_end);
            return true;
        }
        ++at->span;
    }
    return false;
}

/* Sums of a block of nodes: of the damping's power, of N.u, and of what the totals need. */
typedef struct block_sums {
    ss_pair power, volume, kinetic, rest, most;
} block_sums;

/* a of two nodes. */
SS_INLINE ss_pair acceleration(const ss_cnn_stage *s, int32_t i, ss_pair v, bool has_source,
                               bool has_pressure, ss_pair *power)
{
    const ptrdiff_t at = 4 * (ptrdiff_t)i;
    const ss_pair gamma_v = ss_pair_mul(ss_pair_each(s->damping + i), v);
    ss_pair f = ss_pair_sub(ss_pair_load(s->force + at), gamma_v);
    f = ss_pair_fnma(ss_pair_each(s->rest_stiffness + i), ss_pair_load(s->d + at), f);
    if (has_source) {
        f = ss_pair_fnma(ss_pair_all((ss_real)s->c1), ss_pair_load(s->r + at), f);
        f = ss_pair_fma(ss_pair_all((ss_real)s->c2), ss_pair_load(s->b + at), f);
    }
    if (has_pressure) {
        f = ss_pair_fnma(ss_pair_all((ss_real)s->pressure), ss_pair_load(s->normal + at), f);
    }
    *power = ss_pair_fma(gamma_v, v, *power);
    return ss_pair_mul(ss_pair_load(s->mobility + at), f);
}

/* The step's end. With v_1 = v0, v_2 to v_4 the stages' velocities, h a_1 = 2 (v_2 - v0),
 * h a_2 = 2 (v_3 - v0) and h a_3 = v_4 - v0:
 *   u = u0 + h/6 (v0 + 2 v_2 + 2 v_3 + v_4),  v = v0 + (h a_1 + 2 h a_2 + 2 h a_3 + h a_4) / 6
 * u is summed with its rounding error kept (Kahan): a slow return moves less than the last digit
 * of u in a step, and would stop short of rest without it. Returns u. */
SS_INLINE ss_pair finish_nodes(const ss_cnn_stage *s, int32_t i, ss_pair a, ss_pair v4, ss_pair h6,
                               block_sums *sums)
{
    const ptrdiff_t at = 4 * (ptrdiff_t)i;
    const ss_pair third = ss_pair_all((ss_real)(1.0 / 3.0)), two = ss_pair_all((ss_real)2);
    const ss_pair u0 = ss_pair_load(s->u0 + at), v0 = ss_pair_load(s->v0 + at);
    const ss_pair v2 = ss_pair_load(s->vs[0] + at), v3 = ss_pair_load(s->vs[1] + at);
    const ss_pair middle = ss_pair_fma(two, v3, ss_pair_add(v2, v4)); /* v2 + 2 v3 + v4 */
    const ss_pair du =
        ss_pair_fma(h6, ss_pair_add(ss_pair_add(v0, v2), middle), ss_pair_load(s->low0 + at));
    const ss_pair u = ss_pair_add(u0, du);
    const ss_pair dv = ss_pair_fma(two, ss_pair_sub(v3, v0),
                                   ss_pair_add(ss_pair_sub(v2, v0), ss_pair_sub(v4, v0)));
    const ss_pair v = ss_pair_add(v0, ss_pair_fma(third, dv, ss_pair_mul(h6, a)));
    ss_pair_store(s->low + at, ss_pair_sub(du, ss_pair_sub(u, u0)));
    ss_pair_store(s->u + at, u);
    ss_pair_store(s->v + at, v);
    const ss_pair uu = ss_pair_mul(u, u);
    sums->kinetic = ss_pair_fma(ss_pair_mul(ss_pair_each(s->mass + i), v), v, sums->kinetic);
    sums->rest = ss_pair_fma(ss_pair_each(s->rest_stiffness + i), uu, sums->rest);
    sums->most = ss_pair_most(uu, sums->most);
    return u;
}

static void add_totals(const block_sums *sums, ss_cnn_totals *totals)
{
    const double square = ss_quad_sum(ss_pair_fold(sums->most));
    totals->kinetic += ss_pair_sum(sums->kinetic);
    totals->rest += ss_pair_sum(sums->rest);
    totals->largest = square > totals->largest ? square : totals->largest;
}

/* The stage loop for one combination of what this body uses. */
SS_INLINE double stage_nodes(ss_cnn_stage *s, bool has_source, bool has_pressure, int32_t index)
{
    const ss_real *v_now = index == 0 ? s->v0 : s->vs[index - 1];
    const ss_pair step = ss_pair_all((ss_real)(index == 2 ? s->h : 0.5 * s->h));
    const ss_pair h6 = ss_pair_all((ss_real)(s->h / 6.0));
    double power = 0.0;
    s->volume = 0.0;
    s->totals = (ss_cnn_totals){0};
    block_range at_block = {.part = s->part};
    while (next_block(&at_block)) {
        const ss_pair zero = ss_pair_all(0);
        block_sums sums = {zero, zero, zero, zero, zero};
        for (int32_t i = at_block.first; i < at_block.end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_pair v = ss_pair_load(v_now + at);
            const ss_pair a = acceleration(s, i, v, has_source, has_pressure, &sums.power);
            ss_pair u;
            if (index == 3) {
                u = finish_nodes(s, i, a, v, h6, &sums);
            } else {
                u = ss_pair_fma(step, v, ss_pair_load(s->u0 + at));
                ss_pair_store(s->us + at, u);
                ss_pair_store(s->vs[index] + at,
                              ss_pair_fma(step, a, index == 0 ? v : ss_pair_load(s->v0 + at)));
            }
            if (has_pressure) {
                sums.volume = ss_pair_fma(ss_pair_load(s->normal + at), u, sums.volume);
            }
        }
        power += ss_pair_sum(sums.power);
        s->volume += has_pressure ? ss_pair_sum(sums.volume) : 0.0;
        if (index == 3) {
            add_totals(&sums, &s->totals);
        }
    }
    return power;
}

SS_INLINE double stage_index(ss_cnn_stage *s, int32_t index)
{
    if (s->r) {
        return s->normal ? stage_nodes(s, true, true, index) : stage_nodes(s, true, false, index);
    }
    return s->normal ? stage_nodes(s, false, true, index) : stage_nodes(s, false, false, index);
}

static double stage(ss_cnn_stage *s)
{
    switch (s->index) {
    case 0:
        return stage_index(s, 0);
    case 1:
        return stage_index(s, 1);
    case 2:
        return stage_index(s, 2);
    default:
        return stage_index(s, 3);
    }
}

static void total(const ss_cnn_part *part, const ss_real *u, const ss_real *v,
                  const ss_real *rest_stiffness, const ss_real *mass, ss_cnn_totals *out)
{
    *out = (ss_cnn_totals){0};
    block_range at_block = {.part = part};
    while (next_block(&at_block)) {
        const ss_pair zero = ss_pair_all(0);
        block_sums sums = {zero, zero, zero, zero, zero};
        for (int32_t i = at_block.first; i < at_block.end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_pair vi = ss_pair_load(v + at), ui = ss_pair_load(u + at);
            const ss_pair uu = ss_pair_mul(ui, ui);
            sums.kinetic = ss_pair_fma(ss_pair_mul(ss_pair_each(mass + i), vi), vi, sums.kinetic);
            sums.rest = ss_pair_fma(ss_pair_each(rest_stiffness + i), uu, sums.rest);
            sums.most = ss_pair_most(uu, sums.most);
        }
        add_totals(&sums, out);
    }
}

static void axpy(const ss_cnn_part *part, double s, const ss_real *x, ss_real *y)
{
    const ss_pair factor = ss_pair_all((ss_real)s);
    block_range at_block = {.part = part};
    while (next_block(&at_block)) {
        for (int32_t i = at_block.first; i < at_block.end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            ss_pair_store(y + at, ss_pair_fma(factor, ss_pair_load(x + at), ss_pair_load(y + at)));
        }
    }
}

static double dot(const ss_cnn_part *part, const ss_real *x, const ss_real *y)
{
    double sum = 0.0;
    block_range at_block = {.part = part};
    while (next_block(&at_block)) {
        ss_pair block = ss_pair_all(0);
        for (int32_t i = at_block.first; i < at_block.end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            block = ss_pair_fma(ss_pair_load(x + at), ss_pair_load(y + at), block);
        }
        sum += ss_pair_sum(block);
    }
    return sum;
}

static double weighted_square(const ss_cnn_part *part, const ss_real *r, const ss_real *mobility)
{
    double sum = 0.0;
    block_range at_block = {.part = part};
    while (next_block(&at_block)) {
        ss_pair block = ss_pair_all(0);
        for (int32_t i = at_block.first; i < at_block.end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_pair ri = ss_pair_load(r + at);
            block = ss_pair_fma(ss_pair_mul(ri, ri), ss_pair_load(mobility + at), block);
        }
        sum += ss_pair_sum(block);
    }
    return sum;
}

static double tangent(const ss_cnn_part *part, const ss_real *rest_stiffness, const ss_real *x,
                      double c, const ss_real *y, ss_real *out)
{
    const ss_pair factor = ss_pair_all((ss_real)c);
    double sum = 0.0;
    block_range at_block = {.part = part};
    while (next_block(&at_block)) {
        ss_pair block = ss_pair_all(0);
        for (int32_t i = at_block.first; i < at_block.end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_pair xi = ss_pair_load(x + at);
            const ss_pair ks_x = ss_pair_mul(ss_pair_each(rest_stiffness + i), xi);
            ss_pair value = ss_pair_sub(ks_x, ss_pair_load(out + at));
            if (y) {
                value = ss_pair_fma(factor, ss_pair_load(y + at), value);
            }
            ss_pair_store(out + at, value);
            block = ss_pair_fma(xi, value, block);
        }
        sum += ss_pair_sum(block);
    }
    return sum;
}

static double descend(const ss_cnn_part *part, double s, const ss_real *p, const ss_real *q,
                      const ss_real *inverse, ss_real *y, ss_real *res, ss_real *z)
{
    const ss_pair factor = ss_pair_all((ss_real)s);
    double sum = 0.0;
    block_range at_block = {.part = part};
    while (next_block(&at_block)) {
        ss_pair block = ss_pair_all(0);
        for (int32_t i = at_block.first; i < at_block.end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_pair left = ss_pair_fnma(factor, ss_pair_load(q + at), ss_pair_load(res + at));
            const ss_pair zi = ss_pair_mul(ss_pair_load(inverse + at), left);
            ss_pair_store(y + at, ss_pair_fma(factor, ss_pair_load(p + at), ss_pair_load(y + at)));
            ss_pair_store(res + at, left);
            ss_pair_store(z + at, zi);
            block = ss_pair_fma(left, zi, block);
        }
        sum += ss_pair_sum(block);
    }
    return sum;
}

static void add_rows(const ss_cnn_part *part, double c, const ss_real *b, double *stiff)
{
    for (int32_t k = 0; k < part->count; ++k) {
        for (int32_t i = part->span[k].node; i < part->span[k].node_end; ++i) {
            stiff[i] += c * (double)b[4 * (ptrdiff_t)i + 3];
        }
    }
}

static double largest(const ss_cnn_part *part, const double *a, const double *b)
{
    double most[4] = {0.0, 0.0, 0.0, 0.0};
    for (int32_t k = 0; k < part->count; ++k) {
        for (int32_t i = part->span[k].node; i < part->span[k].node_end; ++i) {
            const double value = a[i] * b[i];
            most[i % 4] = value > most[i % 4] ? value : most[i % 4];
        }
    }
    const double x = most[0] > most[1] ? most[0] : most[1];
    const double y = most[2] > most[3] ? most[2] : most[3];
    return x > y ? x : y;
}

static void follow(const ss_cnn_part *part, int32_t count, const ss_real *const *f, const double *y,
                   const double *w, const ss_real *mobility, ss_real *u, ss_real *v)
{
    block_range at_block = {.part = part};
    while (next_block(&at_block)) {
        for (int32_t i = at_block.first; i < at_block.end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            ss_pair ui = ss_pair_all(0), vi = ss_pair_all(0);
            for (int32_t m = 0; m < count; ++m) {
                const ss_pair fi = ss_pair_load(f[m] + at);
                ui = ss_pair_fnma(ss_pair_all((ss_real)y[m]), fi, ui);
                vi = ss_pair_fnma(ss_pair_all((ss_real)w[m]), fi, vi);
            }
            const ss_pair inverse = ss_pair_load(mobility + at);
            ss_pair_store(u + at, ss_pair_mul(inverse, ui));
            ss_pair_store(v + at, ss_pair_mul(inverse, vi));
        }
    }
}

static void follow_nodes(int32_t node_count, const int32_t *node, int32_t count,
                         const ss_real *const *f, const double *y, const ss_real *mobility,
                         ss_real *u)
{
    for (int32_t k = 0; k < node_count; ++k) {
        const int32_t at = node[k];
        ss_quad ui = ss_quad_all(0);
        for (int32_t m = 0; m < count; ++m) {
            ui = ss_quad_fnma(ss_quad_all((ss_real)y[m]), ss_quad_load(f[m] + at), ui);
        }
        ss_quad_store(u + at, ss_quad_mul(ss_quad_load(mobility + at), ui));
    }
}

static void neglect(const ss_cnn_part *part, double c, const ss_real *r, const ss_real *b,
                    ss_real *out)
{
    static const _Alignas(32) ss_real first_three[8] = {1, 1, 1, 0, 1, 1, 1, 0};
    const ss_pair factor = ss_pair_all((ss_real)c), mask = ss_pair_load(first_three);
    block_range at_block = {.part = part};
    while (next_block(&at_block)) {
        for (int32_t i = at_block.first; i < at_block.end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_pair bi = ss_pair_load(b + at);
            const ss_pair left = ss_pair_fnma(mask, ss_pair_load(r + at), bi);
            ss_pair_store(out + at, ss_pair_fma(factor, left, ss_pair_load(out + at)));
        }
    }
}

static void watch(int32_t node, int32_t node_end, double rate2, const ss_real *u, const ss_real *v,
                  const ss_real *far_u, const ss_real *far_v, const ss_real *force,
                  const ss_real *mobility, ss_cnn_unrest *out)
{
    const ss_pair period2 = ss_pair_all((ss_real)(1.0 / rate2)), one = ss_pair_all(1);
    ss_pair displacement = ss_pair_all(0), motion = displacement, drive = displacement;
    ss_pair sum = displacement;
    for (int32_t i = node; i < node_end; i += 2) {
        const ptrdiff_t at = 4 * (ptrdiff_t)i;
        const ss_pair ui = ss_pair_load(u + at), f = ss_pair_load(force + at);
        const ss_pair du = ss_pair_sub(ui, ss_pair_load(far_u + at));
        const ss_pair dv = ss_pair_sub(ss_pair_load(v + at), ss_pair_load(far_v + at));
        const ss_pair moved = ss_pair_fma(ss_pair_mul(period2, dv), dv, ss_pair_mul(du, du));
        const ss_pair compliance = ss_pair_mul(period2, ss_pair_load(mobility + at)); /* 1/ks */
        const ss_pair alone = ss_pair_mul(compliance, f);
        const ss_pair share = ss_pair_div(alone, ss_pair_fma(compliance, ss_pair_last(f), one));
        displacement = ss_pair_most(ss_pair_mul(ui, ui), displacement);
        motion = ss_pair_most(moved, motion);
        drive = ss_pair_most(ss_pair_mul(share, share), drive);
        sum = ss_pair_add(sum, alone);
    }
    const ss_quad mean =
        ss_quad_mul(ss_quad_all((ss_real)(1.0 / (node_end - node))), ss_pair_both(sum));
    const double together = ss_quad_sum(ss_quad_mul(mean, mean));
    *out = (ss_cnn_unrest){ss_quad_sum(ss_pair_fold(displacement)),
                           ss_quad_sum(ss_pair_fold(motion)), ss_quad_sum(ss_pair_fold(drive))};
    out->drive = together > out->drive ? together : out->drive;
}

/* ---- columns ---- */

/* A row of columns side by side. */
typedef double row_of_columns
    __attribute__((vector_size(SS_CNN_SOLVE_WIDTH * sizeof(double)), aligned(8), may_alias));

typedef int64_t row_of_bits __attribute__((vector_size(SS_CNN_SOLVE_WIDTH * sizeof(int64_t))));

/* rho |ghat_i - ghat_j| of an edge. */
SS_INLINE void edge_flux(const ss_cnn_edges *edges, int32_t e, const double *rho,
                         const row_of_columns *ghat, row_of_columns *out)
{
    const row_of_columns d = ghat[edges->from[e] / 4] - ghat[edges->to[e] / 4];
    *out = rho[e] * (row_of_columns)((row_of_bits)d & INT64_MAX);
}

static void solve(int32_t n, const int *column, const int *row, const double *lower,
                  const double *diagonal, double (*x)[SS_CNN_SOLVE_WIDTH])
{
    row_of_columns *at = (row_of_columns *)(void *)x;
    for (int32_t j = 0; j < n; ++j) {
        const row_of_columns from = at[j];
        for (int p = column[j]; p < column[j + 1]; ++p) {
            at[row[p]] -= lower[p] * from;
        }
    }
    for (int32_t j = n - 1; j >= 0; --j) {
        row_of_columns sum = at[j] / diagonal[j];
        for (int p = column[j]; p < column[j + 1]; ++p) {
            sum -= lower[p] * at[row[p]];
        }
        at[j] = sum;
    }
}

static void fluxes(const ss_cnn_edges *edges, const double *rho, const double *square,
                   const double (*ghat)[SS_CNN_SOLVE_WIDTH], int32_t count, double *out_qhat,
                   ss_real *const *out)
{
    const row_of_columns *at = (const row_of_columns *)(const void *)ghat;
    row_of_columns qhat = {0};
    for (int32_t e = 0; e < edges->count; ++e) {
        row_of_columns flux;
        edge_flux(edges, e, rho, at, &flux);
        qhat += flux;
    }
    for (int32_t k = 0; k < count; ++k) {
        out_qhat[k] = qhat[k];
    }
    for (int32_t e = 0; out != NULL && e < edges->count; ++e) {
        row_of_columns kap;
        edge_flux(edges, e, rho, at, &kap);
        kap /= square[e] * qhat;
        for (int32_t k = 0; k < count; ++k) {
            out[k][e] = (ss_real)kap[k];
        }
    }
}

/* ---- the table ---- */

SS_KERNEL_TABLE(ss_cnn_kernels, .product = product, .scatter = scatter, .strain = strain,
                .combine = combine, .stage = stage, .total = total, .axpy = axpy, .dot = dot,
                .tangent = tangent, .descend = descend, .add_rows = add_rows, .largest = largest,
                .weighted_square = weighted_square, .follow = follow, .follow_nodes = follow_nodes,
                .neglect = neglect, .watch = watch, .solve = solve, .fluxes = fluxes);
