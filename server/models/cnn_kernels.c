/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn_kernels.h"
/*
 * The kernels, written once. This file is compiled for the baseline processor as it stands, and
 * once more by cnn_kernels_avx2.c with 256-bit vectors and fused multiply-add.
 *
 * Where the time goes: the product reads three things an entry (neighbour, kap, u of the
 * neighbour) and is bound by loads, so differences u_i - u_j are free, and they lose no digits
 * where far nodes move together. Node loops stream from L2. Rejected: products in edge order
 * (half the bytes, but each edge reads, changes and writes r of both ends), padded rows.
 */
#include <stdbool.h>
#include <stddef.h>

#include "models/wide.h"

/* Rows summed in ss_real before a sum goes over to double. */
enum { BLOCK = 32 };

static int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* ---- sparse ------------------------------------------------------------------------------- */

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

SS_INLINE void product_rows(const ss_cnn_rows *rows, const ss_real *kap, const ss_real *b,
                            const ss_real *u, ss_real *r, double *out_ub, double *out_ur)
{
    double ub = 0.0, ur = 0.0;
    for (int32_t g = 0; g < rows->group_count; ++g) {
        const ss_cnn_group *group = &rows->group[g];
        switch (group->degree) { /* constant degrees unroll */
        case 4:
            product_group(rows, group, 4, kap, b, u, r, &ub, &ur);
            break;
        case 5:
            product_group(rows, group, 5, kap, b, u, r, &ub, &ur);
            break;
        case 6:
            product_group(rows, group, 6, kap, b, u, r, &ub, &ur);
            break;
        case 7:
            product_group(rows, group, 7, kap, b, u, r, &ub, &ur);
            break;
        case 8:
            product_group(rows, group, 8, kap, b, u, r, &ub, &ur);
            break;
        default:
            product_group(rows, group, group->degree, kap, b, u, r, &ub, &ur);
            break;
        }
    }
    *out_ub = ub;
    *out_ur = ur;
}

static void product(const ss_cnn_rows *rows, const ss_real *kap, const ss_real *b, const ss_real *u,
                    ss_real *r, double *out_ub, double *out_ur)
{
    if (b) {
        product_rows(rows, kap, b, u, r, out_ub, out_ur);
    } else {
        product_rows(rows, kap, NULL, u, r, out_ub, out_ur);
    }
}

static void scatter(const ss_cnn_rows *rows, const ss_real *kap_edge, ss_real *kap, ss_real *b)
{
    const int32_t *edge = rows->edge;
    const ss_real *arm = rows->arm;
    for (int32_t g = 0; g < rows->group_count; ++g) {
        const int32_t degree = rows->group[g].degree;
        const int32_t *node = rows->node + rows->group[g].first_row;
        for (int32_t row = 0; row < rows->group[g].row_count; ++row) {
            ss_quad bi = ss_quad_all(0);
            for (int32_t k = 0; k < degree; ++k) {
                const ss_real value = kap_edge[edge[k]];
                kap[k] = value;
                bi = ss_quad_fma(ss_quad_all(value), ss_quad_load(arm + 4 * k), bi);
            }
            ss_quad_store(b + node[row], bi);
            edge += degree;
            kap += degree;
            arm += 4 * (ptrdiff_t)degree;
        }
    }
}

/* ---- edges -------------------------------------------------------------------------------- */

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

/* ---- nodes -------------------------------------------------------------------------------- */

/* Sums of a block of rows: of the damping's power, and of what the totals need. */
typedef struct block_sums {
    ss_quad power, kinetic, rest, square;
} block_sums;

/* a of one node. */
SS_INLINE ss_quad acceleration(const ss_cnn_stage *s, int32_t i, ss_quad v, bool has_source,
                               bool has_pretension, bool has_pressure, ss_quad *power)
{
    const ptrdiff_t at = 4 * (ptrdiff_t)i;
    const ss_quad gamma_v = ss_quad_mul(ss_quad_all(s->damping[i]), v);
    ss_quad f = ss_quad_sub(ss_quad_load(s->force + at), gamma_v);
    f = ss_quad_fnma(ss_quad_all(s->rest_stiffness[i]), ss_quad_load(s->d + at), f);
    if (has_source) {
        f = ss_quad_fnma(ss_quad_all((ss_real)s->c1), ss_quad_load(s->r + at), f);
    }
    if (has_pretension) {
        f = ss_quad_fma(ss_quad_all((ss_real)s->c2), ss_quad_load(s->b + at), f);
    }
    if (has_pressure) {
        f = ss_quad_fnma(ss_quad_all((ss_real)s->pressure), ss_quad_load(s->normal + at), f);
    }
    *power = ss_quad_fma(gamma_v, v, *power);
    return ss_quad_mul(ss_quad_load(s->mobility + at), f);
}

/* The step's end. With v_1 = v0, v_2 to v_4 the stages' velocities, h a_1 = 2 (v_2 - v0),
 * h a_2 = 2 (v_3 - v0) and h a_3 = v_4 - v0:
 *   u = u0 + h/6 (v0 + 2 v_2 + 2 v_3 + v_4),  v = v0 + (h a_1 + 2 h a_2 + 2 h a_3 + h a_4) / 6
 * u is summed with its rounding error kept (Kahan): a slow return moves less than the last digit
 * of u in a step, and would stop short of rest without it. */
SS_INLINE void finish_node(const ss_cnn_stage *s, int32_t i, ss_quad a, ss_quad v4, ss_quad h6,
                           block_sums *sums)
{
    const ptrdiff_t at = 4 * (ptrdiff_t)i;
    const ss_quad third = ss_quad_all((ss_real)(1.0 / 3.0)), two = ss_quad_all((ss_real)2);
    const ss_quad u0 = ss_quad_load(s->u0 + at), v0 = ss_quad_load(s->v0 + at);
    const ss_quad v2 = ss_quad_load(s->vs[0] + at), v3 = ss_quad_load(s->vs[1] + at);
    const ss_quad middle = ss_quad_fma(two, v3, ss_quad_add(v2, v4)); /* v2 + 2 v3 + v4 */
    const ss_quad du =
        ss_quad_fma(h6, ss_quad_add(ss_quad_add(v0, v2), middle), ss_quad_load(s->low0 + at));
    const ss_quad u = ss_quad_add(u0, du);
    const ss_quad dv = ss_quad_fma(two, ss_quad_sub(v3, v0),
                                   ss_quad_add(ss_quad_sub(v2, v0), ss_quad_sub(v4, v0)));
    const ss_quad v = ss_quad_add(v0, ss_quad_fma(third, dv, ss_quad_mul(h6, a)));
    ss_quad_store(s->low + at, ss_quad_sub(du, ss_quad_sub(u, u0)));
    ss_quad_store(s->u + at, u);
    ss_quad_store(s->v + at, v);
    const ss_quad uu = ss_quad_mul(u, u);
    sums->kinetic = ss_quad_fma(ss_quad_mul(ss_quad_all(s->mass[i]), v), v, sums->kinetic);
    sums->rest = ss_quad_fma(ss_quad_all(s->rest_stiffness[i]), uu, sums->rest);
    sums->square = ss_quad_add(sums->square, uu);
}

static void add_totals(const block_sums *sums, ss_cnn_totals *totals)
{
    const double square = ss_quad_sum(sums->square);
    totals->kinetic += ss_quad_sum(sums->kinetic);
    totals->rest += ss_quad_sum(sums->rest);
    totals->largest = square > totals->largest || square != square ? square : totals->largest;
}

/* The stage loop for one combination of what this body uses. */
SS_INLINE double stage_nodes(ss_cnn_stage *s, bool has_source, bool has_pretension,
                             bool has_pressure, int32_t index)
{
    const ss_real *v_now = index == 0 ? s->v0 : s->vs[index - 1];
    const ss_quad step = ss_quad_all((ss_real)(index == 2 ? s->h : 0.5 * s->h));
    const ss_quad h6 = ss_quad_all((ss_real)(s->h / 6.0));
    double power = 0.0;
    s->totals = (ss_cnn_totals){0};
    for (int32_t first = 0; first < s->node_count; first += BLOCK) {
        const int32_t end = least(first + BLOCK, s->node_count);
        const ss_quad zero = ss_quad_all(0);
        block_sums sums = {zero, zero, zero, zero};
        for (int32_t i = first; i < end; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_quad v = ss_quad_load(v_now + at);
            const ss_quad a =
                acceleration(s, i, v, has_source, has_pretension, has_pressure, &sums.power);
            if (index == 3) {
                finish_node(s, i, a, v, h6, &sums);
            } else {
                ss_quad_store(s->us + at, ss_quad_fma(step, v, ss_quad_load(s->u0 + at)));
                ss_quad_store(s->vs[index] + at,
                              ss_quad_fma(step, a, index == 0 ? v : ss_quad_load(s->v0 + at)));
            }
        }
        power += ss_quad_sum(sums.power);
        if (index == 3) {
            add_totals(&sums, &s->totals);
        }
    }
    return power;
}

SS_INLINE double stage_index(ss_cnn_stage *s, int32_t index)
{
    if (!s->normal && s->r && s->c2 == 0.0) {
        return stage_nodes(s, true, false, false, index);
    }
    if (!s->normal && s->r) {
        return stage_nodes(s, true, true, false, index);
    }
    if (s->r) {
        return stage_nodes(s, true, true, true, index);
    }
    return s->normal ? stage_nodes(s, false, false, true, index)
                     : stage_nodes(s, false, false, false, index);
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

static void total(int32_t node_count, const ss_real *u, const ss_real *v,
                  const ss_real *rest_stiffness, const ss_real *mass, ss_cnn_totals *out)
{
    *out = (ss_cnn_totals){0};
    for (int32_t first = 0; first < node_count; first += BLOCK) {
        const int32_t end = least(first + BLOCK, node_count);
        const ss_quad zero = ss_quad_all(0);
        block_sums sums = {zero, zero, zero, zero};
        for (int32_t i = first; i < end; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_quad vi = ss_quad_load(v + at), ui = ss_quad_load(u + at);
            const ss_quad uu = ss_quad_mul(ui, ui);
            sums.kinetic = ss_quad_fma(ss_quad_mul(ss_quad_all(mass[i]), vi), vi, sums.kinetic);
            sums.rest = ss_quad_fma(ss_quad_all(rest_stiffness[i]), uu, sums.rest);
            sums.square = ss_quad_add(sums.square, uu);
        }
        add_totals(&sums, out);
    }
}

static void axpy(int32_t node_count, double s, const ss_real *x, ss_real *y)
{
    const ss_quad factor = ss_quad_all((ss_real)s);
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)node_count; at += 4) {
        ss_quad_store(y + at, ss_quad_fma(factor, ss_quad_load(x + at), ss_quad_load(y + at)));
    }
}

static double dot(int32_t node_count, const ss_real *x, const ss_real *y)
{
    double sum = 0.0;
    for (int32_t first = 0; first < node_count; first += BLOCK) {
        const int32_t end = least(first + BLOCK, node_count);
        ss_quad block = ss_quad_all(0);
        for (int32_t i = first; i < end; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            block = ss_quad_fma(ss_quad_load(x + at), ss_quad_load(y + at), block);
        }
        sum += ss_quad_sum(block);
    }
    return sum;
}

static double scale(int32_t node_count, const ss_real *a, const ss_real *b, ss_real *out)
{
    double sum = 0.0;
    for (int32_t first = 0; first < node_count; first += BLOCK) {
        const int32_t end = least(first + BLOCK, node_count);
        ss_quad block = ss_quad_all(0);
        for (int32_t i = first; i < end; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_quad bi = ss_quad_load(b + at);
            const ss_quad product_i = ss_quad_mul(ss_quad_load(a + at), bi);
            block = ss_quad_fma(bi, product_i, block);
            ss_quad_store(out + at, product_i);
        }
        sum += ss_quad_sum(block);
    }
    return sum;
}

static double weighted_square(int32_t node_count, const ss_real *r, const ss_real *mobility)
{
    double sum = 0.0;
    for (int32_t first = 0; first < node_count; first += BLOCK) {
        const int32_t end = least(first + BLOCK, node_count);
        ss_quad block = ss_quad_all(0);
        for (int32_t i = first; i < end; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_quad ri = ss_quad_load(r + at);
            block = ss_quad_fma(ss_quad_mul(ri, ri), ss_quad_load(mobility + at), block);
        }
        sum += ss_quad_sum(block);
    }
    return sum;
}

static double tangent(int32_t node_count, const ss_real *rest_stiffness, const ss_real *x, double c,
                      const ss_real *y, ss_real *out)
{
    const ss_quad factor = ss_quad_all((ss_real)c);
    double sum = 0.0;
    for (int32_t first = 0; first < node_count; first += BLOCK) {
        const int32_t end = least(first + BLOCK, node_count);
        ss_quad block = ss_quad_all(0);
        for (int32_t i = first; i < end; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_quad xi = ss_quad_load(x + at);
            const ss_quad ks_x = ss_quad_mul(ss_quad_all(rest_stiffness[i]), xi);
            ss_quad value = ss_quad_sub(ks_x, ss_quad_load(out + at));
            if (y) {
                value = ss_quad_fma(factor, ss_quad_load(y + at), value);
            }
            ss_quad_store(out + at, value);
            block = ss_quad_fma(xi, value, block);
        }
        sum += ss_quad_sum(block);
    }
    return sum;
}

static double descend(int32_t node_count, double s, const ss_real *p, const ss_real *q,
                      const ss_real *inverse, ss_real *y, ss_real *res, ss_real *z)
{
    const ss_quad factor = ss_quad_all((ss_real)s);
    double sum = 0.0;
    for (int32_t first = 0; first < node_count; first += BLOCK) {
        const int32_t end = least(first + BLOCK, node_count);
        ss_quad block = ss_quad_all(0);
        for (int32_t i = first; i < end; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_quad left = ss_quad_fnma(factor, ss_quad_load(q + at), ss_quad_load(res + at));
            const ss_quad zi = ss_quad_mul(ss_quad_load(inverse + at), left);
            ss_quad_store(y + at, ss_quad_fma(factor, ss_quad_load(p + at), ss_quad_load(y + at)));
            ss_quad_store(res + at, left);
            ss_quad_store(z + at, zi);
            block = ss_quad_fma(left, zi, block);
        }
        sum += ss_quad_sum(block);
    }
    return sum;
}

static void add_rows(int32_t node_count, double c, const ss_real *b, double *stiff)
{
    for (int32_t i = 0; i < node_count; ++i) {
        stiff[i] += c * (double)b[4 * (ptrdiff_t)i + 3];
    }
}

static double largest(int32_t node_count, const double *a, const double *b)
{
    double most[4] = {0.0, 0.0, 0.0, 0.0};
    for (int32_t i = 0; i < node_count; ++i) {
        const double value = a[i] * b[i];
        most[i % 4] = value > most[i % 4] ? value : most[i % 4];
    }
    const double x = most[0] > most[1] ? most[0] : most[1];
    const double y = most[2] > most[3] ? most[2] : most[3];
    return x > y ? x : y;
}

/* ---- the table ---------------------------------------------------------------------------- */

#ifdef SS_WIDE_AVX2
#define PATH      ss_cnn_kernels_avx2
#define PATH_NAME "avx2+fma"
#else
#define PATH ss_cnn_kernels_baseline
#ifdef SS_WIDE_SSE2
#define PATH_NAME "sse2"
#else
#define PATH_NAME "plain C"
#endif
#endif

extern const ss_cnn_kernels PATH;
const ss_cnn_kernels PATH = {.name = PATH_NAME,
                             .product = product,
                             .scatter = scatter,
                             .strain = strain,
                             .combine = combine,
                             .stage = stage,
                             .total = total,
                             .axpy = axpy,
                             .dot = dot,
                             .scale = scale,
                             .tangent = tangent,
                             .descend = descend,
                             .add_rows = add_rows,
                             .largest = largest,
                             .weighted_square = weighted_square};
