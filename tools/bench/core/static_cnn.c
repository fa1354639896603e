/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/core/static_cnn.h"
/*
 * Zhong, Shirinzadeh, Alici, Smith 2006 with uniform rho, equations (17) and (18), and the closure
 * of server/models/cnn/cnn_energy.c, from the mesh again:
 *
 *   w_ij = (|m j'| + |m k'|) / L_ij          m the side's middle, j', k' its triangles' centroids
 *   sum_j w_ij (g_i - g_j) = S_c on cell c, 0 elsewhere; g = 0 where held
 *   kap  = sum_c w^_c q_c / Qhat_c,          q = |g_i - g_j| / L^2,  Qhat = sum |g_i - g_j|
 *   Pi   = E^ eps+^2 / 2 + T0 u.L u / 2 + 1/2 ks |u|^2 + 1/2 (B/V0) (N.u)^2 - F.u
 *   eps  = u.b + u.L u / 2                   L the Laplacian of kap, b = L P0, r = b + L u
 *
 * Pi is convex, and Newton's method finds its one minimum: with A = (E^ eps+ + T0) L + ks
 *
 *   (A + E^ r r' [eps > 0] + (B/V0) N N') du = F - dPi/du
 *
 * A is the same for x, y and z, and the two terms of rank one are taken in by Woodbury's formula.
 * The potentials' matrix and A have one pattern: it is ordered once (approximate minimum degree),
 * and each is factored (L D L'); each solution is refined once with the residual, taken over the
 * edges, and refused where more than rounding is left. Rejected: dense algebra as in
 * papers/zhong2006/net.c, a third of n^3; the model's own network, whose faults would then be in
 * both fields.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/each.h"
#include "rt/factor.h"
#include "rt/order.h"
#include "rt/vec.h"

/* Of the right-hand side's length: what a refined solve may leave. */
#define SOLVE_TOLERANCE 1e-9
/* Of the displacements' length: Newton's last change; the next would be its square. */
#define NEWTON_TOLERANCE 1e-9
enum { MAX_STEPS = 60 };
/* Of the largest diagonal entry: a pivot that is rounding. */
#define FLAT 1e-13

typedef double vector[3];

/* ---- matrices of a graph ---- */

/* diag(d) + Laplacian(w) of the nodes that are free, and rows of the identity for the others, so
 * that one pattern and one order serve every choice of them. */
typedef struct matrix {
    int n;
    int32_t edge_count;
    const int32_t (*edge)[2];
    int *column, *row, *next; /* both halves; the place of a column's next entry */
    double *value, *rest;
    ss_factor factor;
    const double *weight, *diagonal; /* of the factor: edges; nodes, NULL: 0 */
    const uint8_t *is_still;         /* of the factor: nodes that are not free */
} matrix;

static void fini_matrix(matrix *m)
{
    SS_EACH(free, m->column, m->row, m->next, m->value, m->rest);
    ss_factor_fini(&m->factor);
}

/* Rows of a column: itself, then its neighbours in the order of the edges. */
static void place_entries(matrix *m)
{
    for (int32_t e = 0; e < m->edge_count; ++e) {
        ++m->column[m->edge[e][0] + 1];
        ++m->column[m->edge[e][1] + 1];
    }
    for (int k = 0; k < m->n; ++k) {
        m->column[k + 1] += m->column[k] + 1;
        m->row[m->column[k]] = k;
        m->next[k] = m->column[k] + 1;
    }
    for (int32_t e = 0; e < m->edge_count; ++e) {
        const int i = m->edge[e][0], j = m->edge[e][1];
        m->row[m->next[i]++] = j;
        m->row[m->next[j]++] = i;
    }
}

/* Everything but the numbers. */
static softsim_status init_matrix(matrix *m, int32_t node_count, int32_t edge_count,
                                  const int32_t (*edge)[2])
{
    *m = (matrix){.n = node_count, .edge_count = edge_count, .edge = edge};
    const size_t nodes = (size_t)node_count, entries = nodes + 2 * (size_t)edge_count;
    m->column = calloc(nodes + 1, sizeof *m->column);
    m->row = calloc(entries, sizeof *m->row);
    m->value = calloc(entries, sizeof *m->value);
    m->next = calloc(nodes, sizeof *m->next);
    m->rest = calloc(nodes, sizeof *m->rest);
    if (!m->column || !m->row || !m->value || !m->next || !m->rest) {
        return SOFTSIM_ERROR_MEMORY;
    }
    place_entries(m);
    const softsim_status status = ss_factor_init(&m->factor, m->n, m->column, m->row);
    return status == SOFTSIM_OK ? ss_factor_reserve(&m->factor) : status;
}

/* The factor for these numbers, which stay the caller's; false: not positive definite. */
static bool factorise(matrix *m, const double *weight, const double *diagonal,
                      const uint8_t *is_still)
{
    double largest = 0.0;
    m->weight = weight;
    m->diagonal = diagonal;
    m->is_still = is_still;
    for (int i = 0; i < m->n; ++i) {
        m->value[m->column[i]] = is_still[i] ? 1.0 : diagonal != NULL ? diagonal[i] : 0.0;
        m->next[i] = m->column[i] + 1;
    }
    for (int32_t e = 0; e < m->edge_count; ++e) {
        const int i = m->edge[e][0], j = m->edge[e][1];
        const double between = is_still[i] || is_still[j] ? 0.0 : -weight[e];
        m->value[m->column[i]] += is_still[i] ? 0.0 : weight[e];
        m->value[m->column[j]] += is_still[j] ? 0.0 : weight[e];
        m->value[m->next[i]++] = between;
        m->value[m->next[j]++] = between;
    }
    for (int i = 0; i < m->n; ++i) {
        largest = fmax(largest, is_still[i] ? 0.0 : m->value[m->column[i]]);
    }
    bool is_positive = ss_factor_fill(&m->factor, m->column, m->row, m->value);
    for (int k = 0; is_positive && k < m->n; ++k) {
        is_positive = is_still[m->factor.order[k]] || m->factor.diagonal[k] > FLAT * largest;
    }
    return is_positive;
}

/* x += A^-1 rest. */
static void add_solution(matrix *m, double *x)
{
    ss_factor_solve(&m->factor, m->rest);
    for (int i = 0; i < m->n; ++i) {
        x[i] += m->rest[i];
    }
}

/* rest = b - A x where nodes are free, else 0; returns its length over b's. */
static double find_rest(matrix *m, const double *b, const double *x)
{
    double whole = 0.0, left = 0.0; /* sums of squares: what is no number stays */
    for (int i = 0; i < m->n; ++i) {
        m->rest[i] = b[i] - (m->diagonal != NULL ? m->diagonal[i] * x[i] : 0.0);
        whole += m->is_still[i] ? 0.0 : b[i] * b[i];
    }
    for (int32_t e = 0; e < m->edge_count; ++e) {
        const int i = m->edge[e][0], j = m->edge[e][1];
        const double flow = m->weight[e] * (x[i] - x[j]);
        m->rest[i] -= flow;
        m->rest[j] += flow;
    }
    for (int i = 0; i < m->n; ++i) {
        m->rest[i] = m->is_still[i] ? 0.0 : m->rest[i];
        left += m->rest[i] * m->rest[i];
    }
    return left == 0.0 ? 0.0 : sqrt(left / whole);
}

/* A x = b where nodes are free, else x = 0; false when more than rounding is left. */
static bool solve(matrix *m, const double *b, double *x)
{
    memset(x, 0, (size_t)m->n * sizeof *x);
    for (int pass = 0; pass < 2; ++pass) {
        find_rest(m, b, x);
        add_solution(m, x);
    }
    return find_rest(m, b, x) <= SOLVE_TOLERANCE;
}

/* ---- the body ---- */

/* A triangle's part of one side. */
typedef struct side {
    int32_t node[2];
    double weight;
} side;

typedef struct state {
    const ss_static_cnn_problem *problem;
    int32_t edge_count;
    int32_t (*edge)[2];
    double *conductance, *square, *kap, *tension; /* edges: w, L^2, kap, A's */
    double *area, *ks;                            /* nodes */
    vector *normal;                               /* N_i, m^2 */
    double volume, bulk_rate;                     /* m^3; B/V0, Pa/m^3 */
    side *side;                                   /* of all triangles */
    matrix matrix;                                /* of the potentials, then of the shape */
    uint8_t *is_still;                            /* nodes that are held or given */
    double *source, *potential;                   /* nodes */
    vector *b, *r, *out_of_balance;
    double *column[3][3]; /* A^-1 of what is out of balance, of r and of N, by axis */
} state;

static void fini(state *s)
{
    void *const parts[] = {s->edge, s->conductance, s->square,    s->kap,           s->tension,
                           s->area, s->ks,          s->normal,    s->side,          s->source,
                           s->b,    s->r,           s->potential, s->out_of_balance};
    for (size_t k = 0; k < sizeof parts / sizeof *parts; ++k) {
        free(parts[k]);
    }
    for (int k = 0; k < 9; ++k) {
        free(s->column[k / 3][k % 3]);
    }
    free(s->is_still);
    fini_matrix(&s->matrix);
}

static bool allocate(state *s)
{
    const size_t n = (size_t)s->problem->node_count;
    const size_t sides = 3 * (size_t)s->problem->triangle_count;
    double **const by_side[] = {&s->conductance, &s->square, &s->kap, &s->tension};
    double **const by_node[] = {&s->area, &s->ks, &s->source, &s->potential};
    vector **const vectors[] = {&s->normal, &s->b, &s->r, &s->out_of_balance};
    s->side = calloc(sides, sizeof *s->side);
    s->edge = calloc(sides, sizeof *s->edge);
    s->is_still = calloc(n, sizeof *s->is_still);
    bool is_good = s->side != NULL && s->edge != NULL && s->is_still != NULL;
    for (size_t k = 0; k < 4; ++k) {
        *by_side[k] = calloc(sides, sizeof **by_side[k]);
        *by_node[k] = calloc(n, sizeof **by_node[k]);
        *vectors[k] = calloc(n, sizeof **vectors[k]);
        is_good = is_good && *by_side[k] && *by_node[k] && *vectors[k];
    }
    for (int k = 0; k < 9; ++k) {
        s->column[k / 3][k % 3] = calloc(n, sizeof(double));
        is_good = is_good && s->column[k / 3][k % 3] != NULL;
    }
    return is_good;
}

static int compare_sides(const void *a, const void *b)
{
    const side *x = a, *y = b;
    return ss_order_ints(x->node, y->node, 2);
}

static double distance(const vector a, const vector b)
{
    double way[3];
    ss_sub3(way, b, a);
    return ss_norm3(way);
}

/* What each triangle gives to its sides and corners. */
static void take_triangles(state *s)
{
    const ss_static_cnn_problem *p = s->problem;
    for (int32_t t = 0; t < p->triangle_count; ++t) {
        const int32_t *c = p->triangle[t];
        double n[3], centroid[3] = {0.0};
        ss_normal3(n, p->rest[c[0]], p->rest[c[1]], p->rest[c[2]]);
        s->volume += ss_dot3(n, p->rest[c[0]]) / 6.0;
        for (int k = 0; k < 3; ++k) {
            ss_madd3(centroid, centroid, 1.0 / 3.0, p->rest[c[k]]);
            ss_madd3(s->normal[c[k]], s->normal[c[k]], 1.0 / 6.0, n);
            s->area[c[k]] += ss_norm3(n) / 6.0;
        }
        for (int k = 0; k < 3; ++k) {
            const int32_t i = c[k], j = c[(k + 1) % 3];
            double middle[3];
            ss_add3(middle, p->rest[i], p->rest[j]);
            ss_scale3(middle, middle, 0.5);
            s->side[3 * t + k] =
                (side){.node = {i < j ? i : j, i < j ? j : i},
                       .weight = distance(middle, centroid) / distance(p->rest[i], p->rest[j])};
        }
    }
}

/* One edge for each run of equal sides. */
static void join_sides(state *s)
{
    const ss_static_cnn_problem *p = s->problem;
    const int32_t sides = 3 * p->triangle_count;
    qsort(s->side, (size_t)sides, sizeof *s->side, compare_sides);
    for (int32_t h = 0; h < sides; ++h) {
        const int32_t *node = s->side[h].node;
        if (h == 0 || compare_sides(&s->side[h], &s->side[h - 1]) != 0) {
            const double length = distance(p->rest[node[0]], p->rest[node[1]]);
            s->edge[s->edge_count][0] = node[0];
            s->edge[s->edge_count][1] = node[1];
            s->square[s->edge_count++] = length * length;
        }
        s->conductance[s->edge_count - 1] += s->side[h].weight;
    }
}

/* L x of the flux densities. */
static void multiply(const state *s, const vector *x, vector *out)
{
    memset(out, 0, (size_t)s->problem->node_count * sizeof *out);
    for (int32_t e = 0; e < s->edge_count; ++e) {
        const int32_t i = s->edge[e][0], j = s->edge[e][1];
        double way[3];
        ss_sub3(way, x[i], x[j]);
        ss_madd3(out[i], out[i], s->kap[e], way);
        ss_madd3(out[j], out[j], -s->kap[e], way);
    }
}

static softsim_status refuse(softsim_status status, const char *text, softsim_error *error)
{
    softsim_error_add(error, status, "direct solution of cnn-energy: %s", text);
    return status;
}

/* kap, a solve for each cell of the source; then b. */
static softsim_status spread(state *s, softsim_error *error)
{
    const ss_static_cnn_problem *p = s->problem;
    if (!factorise(&s->matrix, s->conductance, NULL, p->is_held)) {
        return refuse(SOFTSIM_ERROR_MESH, "a part of the surface is not held", error);
    }
    for (int32_t c = 0; c < p->node_count; ++c) {
        if (!(p->weight[c] > 0.0)) {
            continue;
        }
        double whole = 0.0;
        s->source[c] = s->area[c];
        if (!solve(&s->matrix, s->source, s->potential)) {
            return refuse(SOFTSIM_ERROR_SYSTEM, "the potentials are no solution", error);
        }
        s->source[c] = 0.0;
        for (int32_t e = 0; e < s->edge_count; ++e) {
            whole += fabs(s->potential[s->edge[e][0]] - s->potential[s->edge[e][1]]);
        }
        for (int32_t e = 0; e < s->edge_count; ++e) {
            const double drop = fabs(s->potential[s->edge[e][0]] - s->potential[s->edge[e][1]]);
            s->kap[e] += p->weight[c] * drop / (s->square[e] * whole);
        }
    }
    multiply(s, p->rest, s->b);
    return SOFTSIM_OK;
}

static softsim_status build(state *s, softsim_error *error)
{
    const ss_static_cnn_problem *p = s->problem;
    if (!allocate(s)) {
        return SOFTSIM_ERROR_MEMORY;
    }
    take_triangles(s);
    s->bulk_rate = p->bulk > 0.0 ? p->bulk / s->volume : 0.0;
    join_sides(s);
    for (int32_t i = 0; i < p->node_count; ++i) {
        s->ks[i] = p->rest_stiffness * s->area[i];
        s->is_still[i] = p->is_held[i] || (p->is_given != NULL && p->is_given[i]);
    }
    const softsim_status status =
        init_matrix(&s->matrix, p->node_count, s->edge_count, (const int32_t(*)[2])s->edge);
    return status == SOFTSIM_OK ? spread(s, error) : status;
}

/* ---- Newton's method ---- */

/* r, F - dPi/du and A's weights at u; returns eps. */
static double evaluate(state *s, const vector *u)
{
    const ss_static_cnn_problem *p = s->problem;
    double eps = 0.0, change = 0.0;
    multiply(s, u, s->r);
    for (int32_t i = 0; i < p->node_count; ++i) {
        eps += ss_dot3(u[i], s->b[i]) + 0.5 * ss_dot3(u[i], s->r[i]);
        change += ss_dot3(u[i], s->normal[i]);
    }
    const double tension = p->modulus * fmax(eps, 0.0);
    const double pressure = s->bulk_rate * change;
    for (int32_t i = 0; i < p->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double stretched = s->r[i][k];
            s->r[i][k] += s->b[i][k];
            s->out_of_balance[i][k] = (p->force != NULL ? p->force[i][k] : 0.0) -
                                      s->ks[i] * u[i][k] - tension * s->r[i][k] -
                                      p->pretension * stretched - pressure * s->normal[i][k];
        }
    }
    for (int32_t e = 0; e < s->edge_count; ++e) {
        s->tension[e] = (tension + p->pretension) * s->kap[e];
    }
    return eps;
}

/* x.y; x by axis, 0 where nodes are still. */
static double product(const state *s, double *const x[3], const vector *y)
{
    double sum = 0.0;
    for (int32_t i = 0; i < s->problem->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            sum += x[k][i] * y[i][k];
        }
    }
    return sum;
}

/* A^-1 of all three by axis; false: no solution. */
static bool solve_columns(state *s)
{
    vector *const right[3] = {s->out_of_balance, s->r, s->normal};
    for (int k = 0; k < 9; ++k) {
        for (int32_t i = 0; i < s->problem->node_count; ++i) {
            s->source[i] = right[k / 3][i][k % 3];
        }
        if (!solve(&s->matrix, s->source, s->column[k / 3][k % 3])) {
            return false;
        }
    }
    return true;
}

/* u += du; returns the length of du over that of u; NaN: no solution. */
static double step(state *s, vector *u)
{
    const ss_static_cnn_problem *p = s->problem;
    const double eps = evaluate(s, (const vector *)u);
    if (!factorise(&s->matrix, s->tension, s->ks, s->is_still) || !solve_columns(s)) {
        return (double)NAN;
    }
    /* du = x0 - x1 y1 - x2 y2 with y_k = d_k (U_k.du), x_k = A^-1 of the columns. */
    const double d1 = eps > 0.0 ? p->modulus : 0.0, d2 = s->bulk_rate;
    const double m11 = 1.0 + d1 * product(s, s->column[1], (const vector *)s->r);
    const double m12 = d1 * product(s, s->column[2], (const vector *)s->r);
    const double m21 = d2 * product(s, s->column[1], (const vector *)s->normal);
    const double m22 = 1.0 + d2 * product(s, s->column[2], (const vector *)s->normal);
    const double c1 = d1 * product(s, s->column[0], (const vector *)s->r);
    const double c2 = d2 * product(s, s->column[0], (const vector *)s->normal);
    const double y1 = (c1 * m22 - c2 * m12) / (m11 * m22 - m12 * m21);
    const double y2 = (c2 * m11 - c1 * m21) / (m11 * m22 - m12 * m21);
    double whole = 0.0, change = 0.0;
    for (int32_t i = 0; i < p->node_count; ++i) {
        double du[3];
        for (int k = 0; k < 3; ++k) {
            du[k] = s->column[0][k][i] - y1 * s->column[1][k][i] - y2 * s->column[2][k][i];
        }
        ss_add3(u[i], u[i], du);
        whole += ss_dot3(u[i], u[i]);
        change += ss_dot3(du, du);
    }
    return change == 0.0 ? 0.0 : sqrt(change / whole);
}

softsim_status ss_static_cnn_solve(const ss_static_cnn_problem *problem, double (*inout_u)[3],
                                   softsim_error *error)
{
    state s = {.problem = problem};
    softsim_status status = build(&s, error);
    double change = (double)INFINITY;
    for (int32_t i = 0; i < problem->node_count; ++i) { /* wherever the search begins */
        if (problem->is_held[i]) {
            ss_set3(inout_u[i], 0.0, 0.0, 0.0);
        }
    }
    for (int k = 0; status == SOFTSIM_OK && k < MAX_STEPS && change > NEWTON_TOLERANCE; ++k) {
        change = step(&s, inout_u);
    }
    if (status == SOFTSIM_ERROR_MEMORY) {
        refuse(status, "out of memory", error);
    } else if (status == SOFTSIM_OK && !(change <= NEWTON_TOLERANCE)) {
        status = refuse(SOFTSIM_ERROR_SYSTEM, "no equilibrium was found", error);
    }
    fini(&s);
    return status;
}
