/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_quadratic/quadratic.h"
/*
 * A mesh of four-node tetrahedra becomes one of ten nodes. One of second order has them: its nodes
 * are those of the file, where the file has them, and what a plan says of nodes it says of these
 * too, so that nothing is added to it.
 *
 * Edges are numbered as the elements name them first, so that equal meshes give equal numbers and
 * neighbours stay near in memory. Everything that a plan says of nodes is said of the new ones too;
 * the body, its contact and its loads then need to know nothing of the elements.
 *
 * Curved edges. Where the surface is smooth the middle of an edge lies on the cubic with the ends'
 * positions and tangents, the edge projected on their tangent planes (the edge of a curved PN
 * triangle, Vlachos et al. 2001), at (a + b)/2 + (t_a - t_b)/8. A node's normal is the mean of its
 * triangles', weighted by their angles. An edge stays straight where its two triangles, or a normal
 * and one of them, differ by more than CREASE: there the body has an edge. A mesh of second order
 * or a finer surface (surface.c) knows the true shape better; the mean of the surface's own facets
 * is what is always there.
 */
#include <math.h>
#include <string.h>

#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

static const int ends[SS_QUADRATIC_SIDES][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/* cos 40 degrees: the edges of a solid's facets meet at less where it is meshed well. */
#define CREASE 0.766
/* An element whose Jacobian at a Gauss point is below this share of its mean stays straight. */
#define LEAST_JACOBIAN 0.2

/* Edges by their lower node: chains. */
typedef struct edges {
    int32_t node_count, count;
    int32_t *first, *next, *low, *high;
    int32_t *node; /* in the middle of each */
    uint8_t *is_surface;
    int32_t *triangle; /* two of each edge: -1 none */
} edges;

static void edges_free(edges *s)
{
    SS_EACH(ss_memory_free, s->first, s->next, s->low, s->high, s->node, s->is_surface,
            s->triangle);
}

static bool edges_init(edges *s, const ss_mesh *mesh)
{
    const size_t most = SS_QUADRATIC_SIDES * (size_t)mesh->tetrahedron_count;
    *s = (edges){.node_count = mesh->node_count,
                 .first = ss_memory_get((size_t)mesh->node_count, sizeof(int32_t)),
                 .next = ss_memory_get(most, sizeof(int32_t)),
                 .low = ss_memory_get(most, sizeof(int32_t)),
                 .high = ss_memory_get(most, sizeof(int32_t)),
                 .node = ss_memory_get(most, sizeof(int32_t)),
                 .is_surface = ss_memory_get(most, 1),
                 .triangle = ss_memory_get(2 * most, sizeof(int32_t))};
    if (!s->first || !s->next || !s->low || !s->high || !s->node || !s->is_surface ||
        !s->triangle) {
        return false;
    }
    memset(s->first, 0xff, (size_t)mesh->node_count * sizeof *s->first);
    memset(s->triangle, 0xff, 2 * most * sizeof *s->triangle);
    return true;
}

/* The number of the edge a-b, -1 if there is none yet. */
static int32_t find(const edges *s, int32_t a, int32_t b)
{
    const int32_t low = a < b ? a : b, high = a < b ? b : a;
    int32_t k = s->first[low];
    while (k >= 0 && s->high[k] != high) {
        k = s->next[k];
    }
    return k;
}

static int32_t add(edges *s, int32_t a, int32_t b)
{
    int32_t k = find(s, a, b);
    if (k < 0) {
        k = s->count++;
        s->node[k] = s->node_count + k;
        s->low[k] = a < b ? a : b;
        s->high[k] = a < b ? b : a;
        s->next[k] = s->first[s->low[k]];
        s->first[s->low[k]] = k;
    }
    return k;
}

/* ---- the mesh ---- */

/* Each triangle in four; false where the surface is not the elements'. */
static bool split_surface(const ss_mesh *mesh, edges *s, int32_t (*out)[3])
{
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        int32_t m[3];
        for (int k = 0; k < 3; ++k) {
            const int32_t e = find(s, c[k], c[(k + 1) % 3]);
            if (e < 0) {
                return false;
            }
            s->is_surface[e] = 1;
            s->triangle[2 * e + (s->triangle[2 * e] >= 0)] = t;
            m[k] = s->node[e];
        }
        int32_t(*four)[3] = out + 4 * (ptrdiff_t)t;
        for (int k = 0; k < 3; ++k) {
            four[k][0] = c[k];
            four[k][1] = m[k];
            four[k][2] = m[(k + 2) % 3];
            four[3][k] = m[k];
        }
    }
    return true;
}

static void triangle_vector(const ss_mesh *mesh, int32_t t, double out[3])
{
    double a[3], b[3];
    const int32_t *c = mesh->triangle[t];
    ss_sub3(a, mesh->position[c[1]], mesh->position[c[0]]);
    ss_sub3(b, mesh->position[c[2]], mesh->position[c[0]]);
    ss_cross3(out, a, b);
    const double size = ss_norm3(out);
    ss_scale3(out, out, size > 0.0 ? 1.0 / size : 0.0);
}

/* Unit normals of the surface's nodes, weighted by angles. */
static void node_normals(const ss_mesh *mesh, double (*out)[3])
{
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        double n[3];
        triangle_vector(mesh, t, n);
        for (int k = 0; k < 3; ++k) {
            const int32_t *c = mesh->triangle[t];
            double a[3], b[3], cross[3];
            ss_sub3(a, mesh->position[c[(k + 1) % 3]], mesh->position[c[k]]);
            ss_sub3(b, mesh->position[c[(k + 2) % 3]], mesh->position[c[k]]);
            ss_cross3(cross, a, b);
            const double angle = atan2(ss_norm3(cross), ss_dot3(a, b));
            for (int i = 0; i < 3; ++i) {
                out[c[k]][i] += angle * n[i];
            }
        }
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        const double size = ss_norm3(out[i]);
        ss_scale3(out[i], out[i], size > 0.0 ? 1.0 / size : 0.0);
    }
}

/* Moves the middle of edge k off the straight one; false where it stays. */
static bool curve_edge(const ss_mesh *mesh, const edges *s, const double (*normal)[3], int32_t k,
                       double position[3])
{
    const int32_t node[2] = {s->low[k], s->high[k]};
    double d[3], face[2][3];
    ss_sub3(d, mesh->position[node[1]], mesh->position[node[0]]);
    for (int f = 0; f < 2; ++f) {
        if (s->triangle[2 * k + f] < 0) {
            return false;
        }
        triangle_vector(mesh, s->triangle[2 * k + f], face[f]);
    }
    bool is_smooth = ss_dot3(face[0], face[1]) > CREASE;
    for (int e = 0; e < 4; ++e) {
        is_smooth = is_smooth && ss_dot3(face[e / 2], normal[node[e % 2]]) > CREASE;
    }
    for (int e = 0; is_smooth && e < 2; ++e) {
        const double *n = normal[node[e]];
        for (int i = 0; i < 3; ++i) {
            position[i] += (e == 0 ? -0.125 : 0.125) * ss_dot3(d, n) * n[i];
        }
    }
    return is_smooth;
}

/* The straight middle of edge k. */
static void straight(const edges *s, const ss_mesh *mesh, int32_t k, double out[3])
{
    ss_add3(out, mesh->position[s->low[k]], mesh->position[s->high[k]]);
    ss_scale3(out, out, 0.5);
}

/* Edges of elements that would be bent too far become straight, all edges of such an element. */
static void straighten(const edges *s, ss_quadratic_raised *raised, uint8_t *is_curved)
{
    ss_mesh *mesh = &raised->mesh;
    bool is_again = true;
    while (is_again) {
        is_again = false;
        for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
            ss_quadratic_point point[SS_QUADRATIC_POINTS];
            double least = (double)INFINITY, mean = 0.0;
            const int32_t *node = raised->node[t];
            int32_t edge[SS_QUADRATIC_SIDES];
            bool is_bent = false;
            for (int k = 0; k < SS_QUADRATIC_SIDES; ++k) {
                edge[k] = find(s, node[ends[k][0]], node[ends[k][1]]);
                is_bent = is_bent || is_curved[edge[k]];
            }
            if (!is_bent) {
                continue;
            }
            (void)ss_quadratic_points(mesh, node, point);
            for (int q = 0; q < SS_QUADRATIC_POINTS; ++q) {
                least = fmin(least, point[q].volume);
                mean += 0.25 * point[q].volume;
            }
            if (least >= LEAST_JACOBIAN * mean) {
                continue;
            }
            for (int k = 0; k < SS_QUADRATIC_SIDES; ++k) {
                if (is_curved[edge[k]]) {
                    is_curved[edge[k]] = 0;
                    is_again = true;
                    --raised->curved_edge_count;
                    ++raised->straightened_edge_count;
                    straight(s, mesh, edge[k], mesh->position[s->node[edge[k]]]);
                }
            }
        }
    }
}

/* An edge of a mesh of second order keeps the file's node where that is off the straight middle by
 * more than rounding. */
static bool keep_edge(const ss_mesh *given, const edges *s, int32_t k, double position[3])
{
    double d[3], off[3];
    straight(s, given, k, position);
    ss_sub3(d, given->position[s->high[k]], given->position[s->low[k]]);
    ss_sub3(off, given->position[s->node[k]], position);
    const bool is_off = ss_norm3(off) > SS_QUADRATIC_STRAIGHT * ss_norm3(d);
    if (is_off) {
        ss_copy3(position, given->position[s->node[k]]);
    }
    return is_off;
}

/* The edges of the surface go to a finer one. */
static bool follow(const ss_mesh *given, const ss_mesh *surface, const edges *s,
                   ss_quadratic_raised *raised, uint8_t *is_curved)
{
    double(*middle)[3] = ss_memory_get((size_t)s->count, sizeof *middle);
    double *length = ss_memory_get((size_t)s->count, sizeof *length);
    int32_t count = 0;
    for (int32_t k = 0; middle && length && k < s->count; ++k) {
        if (s->is_surface[k]) {
            double d[3];
            ss_sub3(d, given->position[s->high[k]], given->position[s->low[k]]);
            straight(s, given, k, middle[count]);
            length[count++] = ss_norm3(d);
        }
    }
    const bool is_good =
        middle && length &&
        ss_quadratic_follow(surface, count, length, middle, &raised->lost_edge_count);
    for (int32_t k = 0, at = 0; is_good && k < s->count; ++k) {
        if (s->is_surface[k]) {
            double *x = raised->mesh.position[s->node[k]], off[3];
            ss_sub3(off, middle[at], x);
            is_curved[k] = ss_norm3(off) > SS_QUADRATIC_STRAIGHT * length[at];
            ss_copy3(x, middle[at++]);
        }
    }
    ss_memory_free(middle);
    ss_memory_free(length);
    return is_good;
}

/* Where normals or the mesh's own nodes lead. */
static bool bend(const ss_mesh *given, const edges *s, ss_quadratic_raised *raised,
                 uint8_t *is_curved)
{
    double(*normal)[3] = ss_memory_get((size_t)given->node_count, sizeof *normal);
    if (normal) {
        if (!given->middle) {
            node_normals(given, normal);
        }
        for (int32_t k = 0; k < s->count; ++k) {
            double *x = raised->mesh.position[s->node[k]];
            is_curved[k] =
                given->middle
                    ? keep_edge(given, s, k, x)
                    : s->is_surface[k] && curve_edge(given, s, (const double(*)[3])normal, k, x);
        }
    }
    ss_memory_free(normal);
    return normal != NULL;
}

static bool curve(const ss_model_plan *plan, const edges *s, ss_quadratic_raised *raised)
{
    uint8_t *is_curved = ss_memory_get((size_t)s->count, 1);
    const bool is_good =
        is_curved && (plan->surface ? follow(plan->mesh, plan->surface, s, raised, is_curved)
                                    : bend(plan->mesh, s, raised, is_curved));
    if (is_good) {
        for (int32_t k = 0; k < s->count; ++k) {
            raised->curved_edge_count += is_curved[k];
        }
        straighten(s, raised, is_curved);
    }
    ss_memory_free(is_curved);
    return is_good;
}

/* ---- sets of nodes ---- */

/* A set of given nodes, by `bits` of each, goes on to the edges. */
static void spread_bits(const edges *s, const ss_quadratic_raised *raised, uint8_t *bits)
{
    uint8_t *of_edge = bits + s->node_count;
    for (int32_t k = 0; k < s->count; ++k) {
        const uint8_t both = bits[s->low[k]] & bits[s->high[k]];
        of_edge[k] = s->is_surface[k] ? both : 0;
    }
    for (int32_t t = 0; t < raised->mesh.tetrahedron_count; ++t) {
        const int32_t *node = raised->node[t];
        const uint8_t all = bits[node[0]] & bits[node[1]] & bits[node[2]] & bits[node[3]];
        for (int k = 4; all && k < SS_QUADRATIC_NODES; ++k) {
            bits[node[k]] |= all;
        }
    }
}

/* `node` and the edges between them; the numbers before and after that are the same. */
static int32_t *extend(const edges *s, const ss_quadratic_raised *raised, const int32_t *node,
                       int32_t count, ss_arena *arena, int32_t *out_count)
{
    uint8_t *bits = ss_memory_get((size_t)raised->mesh.node_count, 1);
    int32_t more = 0, *out = NULL;
    if (bits) {
        for (int32_t i = 0; i < count; ++i) {
            bits[node[i]] = 1;
        }
        spread_bits(s, raised, bits);
        for (int32_t k = 0; k < s->count; ++k) {
            more += bits[s->node_count + k];
        }
        out = ss_arena_get(arena, (size_t)(count + more), sizeof *out);
    }
    if (out) {
        memcpy(out, node, (size_t)count * sizeof *out);
        int32_t at = count;
        for (int32_t k = 0; k < s->count; ++k) {
            if (bits[s->node_count + k]) {
                out[at++] = s->node_count + k;
            }
        }
        *out_count = at;
    }
    ss_memory_free(bits);
    return out;
}

/* ---- prescribed displacements ---- */

enum { TERMS = 6, MAX_NEAR = 96 };
/* Of the fit's own weight: what holds back second derivatives that the nodes say nothing of. */
#define RIDGE 1e-6

/* Nodes of a set, linked by the surface's edges among them. */
typedef struct patch {
    const edges *s;
    const ss_prescribed *set;
    int32_t *place; /* of a given node in the set, -1 */
    int32_t *first; /* links of the i-th: link[first[i]] .. */
    int32_t *link;  /* places */
} patch;

static bool patch_init(patch *p, const edges *s, const ss_prescribed *set)
{
    *p = (patch){.s = s,
                 .set = set,
                 .place = ss_memory_get((size_t)s->node_count, sizeof *p->place),
                 .first = ss_memory_get((size_t)set->node_count + 2, sizeof *p->first),
                 .link = ss_memory_get(2 * (size_t)s->count, sizeof *p->link)};
    if (!p->place || !p->first || !p->link) {
        return false;
    }
    memset(p->place, 0xff, (size_t)s->node_count * sizeof *p->place);
    for (int32_t i = 0; i < set->node_count; ++i) {
        p->place[set->node[i]] = i;
    }
    for (int turn = 0; turn < 2; ++turn) { /* count, then fill */
        for (int32_t k = 0; k < s->count; ++k) {
            const int32_t a = p->place[s->low[k]], b = p->place[s->high[k]];
            if (s->is_surface[k] && a >= 0 && b >= 0) {
                if (turn == 0) {
                    ++p->first[a + 2];
                    ++p->first[b + 2];
                } else {
                    p->link[p->first[a + 1]++] = b;
                    p->link[p->first[b + 1]++] = a;
                }
            }
        }
        for (int32_t i = 0; turn == 0 && i < set->node_count; ++i) {
            p->first[i + 2] += p->first[i + 1];
        }
    }
    return true;
}

static void patch_fini(patch *p)
{
    ss_memory_free(p->place);
    ss_memory_free(p->first);
    ss_memory_free(p->link);
}

static int32_t add_near(int32_t place, int32_t count, int32_t near[MAX_NEAR])
{
    for (int32_t k = 0; k < count; ++k) {
        if (near[k] == place) {
            return count;
        }
    }
    if (count < MAX_NEAR) {
        near[count++] = place;
    }
    return count;
}

/* Both ends and two rings around them. */
static int32_t list_near(const patch *p, int32_t a, int32_t b, int32_t near[MAX_NEAR])
{
    int32_t count = add_near(b, add_near(a, 0, near), near);
    for (int ring = 0, from = 0; ring < 2; ++ring) {
        const int32_t to = count;
        for (; from < to; ++from) {
            for (int32_t k = p->first[near[from]]; k < p->first[near[from] + 1]; ++k) {
                count = add_near(p->link[k], count, near);
            }
        }
    }
    return count;
}

/* Cholesky of a positive definite matrix, in place, and the solution for three right sides. */
static void solve_terms(double a[TERMS][TERMS], double b[TERMS][3])
{
    for (int i = 0; i < TERMS; ++i) {
        for (int j = 0; j <= i; ++j) {
            double sum = a[i][j];
            for (int k = 0; k < j; ++k) {
                sum -= a[i][k] * a[j][k];
            }
            a[i][j] = i == j ? sqrt(sum) : sum / a[j][j];
        }
        for (int c = 0; c < 3; ++c) {
            for (int k = 0; k < i; ++k) {
                b[i][c] -= a[i][k] * b[k][c];
            }
            b[i][c] /= a[i][i];
        }
    }
    for (int i = TERMS - 1; i >= 0; --i) {
        for (int c = 0; c < 3; ++c) {
            for (int k = i + 1; k < TERMS; ++k) {
                b[i][c] -= a[k][i] * b[k][c];
            }
            b[i][c] /= a[i][i];
        }
    }
}

/* 1 s t s^2 st t^2 of a node, about the middle of the edge, in units of its length. */
static void terms_of(const double x[3], const double middle[3], const double axis[2][3],
                     double scale, double out[TERMS])
{
    double d[3];
    ss_sub3(d, x, middle);
    const double s = ss_dot3(d, axis[0]) / scale, t = ss_dot3(d, axis[1]) / scale;
    const double term[TERMS] = {1.0, s, t, s * s, s * t, t * t};
    memcpy(out, term, sizeof term);
}

/* What is prescribed at the middle of edge k: a field that is smooth along the surface, so the
 * quadratic through the nodes around it, where they fix one; it keeps to the ends' values. */
static void prescribe_edge(const patch *p, const ss_mesh *mesh, int32_t k, double out[3])
{
    const int32_t end[2] = {p->place[p->s->low[k]], p->place[p->s->high[k]]};
    const double *x[2] = {mesh->position[p->s->low[k]], mesh->position[p->s->high[k]]};
    const double(*way)[3] = (const double(*)[3])p->set->displacement;
    double middle[3], axis[2][3], normal[3] = {0.0}, a[TERMS][TERMS] = {{0.0}};
    double b[TERMS][3] = {{0.0}};
    int32_t near[MAX_NEAR];
    for (int i = 0; i < 3; ++i) {
        out[i] = 0.5 * (way[end[0]][i] + way[end[1]][i]);
        middle[i] = 0.5 * (x[0][i] + x[1][i]);
        axis[0][i] = x[1][i] - x[0][i];
    }
    const double scale = ss_norm3(axis[0]);
    for (int f = 0; f < 2 && p->s->triangle[2 * k + f] >= 0; ++f) {
        double face[3];
        triangle_vector(mesh, p->s->triangle[2 * k + f], face);
        ss_add3(normal, normal, face);
    }
    ss_cross3(axis[1], normal, axis[0]);
    const double wide = ss_norm3(axis[1]);
    if (!p->s->is_surface[k] || !(wide > 1e-6 * scale)) {
        return;
    }
    ss_scale3(axis[0], axis[0], 1.0 / scale);
    ss_scale3(axis[1], axis[1], 1.0 / wide);
    const int32_t count = list_near(p, end[0], end[1], near);
    for (int32_t n = 0; n < count; ++n) {
        double term[TERMS];
        terms_of(mesh->position[p->set->node[near[n]]], middle, (const double(*)[3])axis, scale,
                 term);
        for (int i = 0; i < TERMS; ++i) {
            for (int j = 0; j < TERMS; ++j) {
                a[i][j] += term[i] * term[j];
            }
            for (int c = 0; c < 3; ++c) {
                b[i][c] += term[i] * way[near[n]][c];
            }
        }
    }
    for (int i = 0; i < TERMS; ++i) {
        a[i][i] += RIDGE * count;
    }
    solve_terms(a, b);
    for (int c = 0; c < 3; ++c) { /* the ends are at s = -1/2 and 1/2 */
        const double bend = -0.25 * b[3][c];
        out[c] += isfinite(bend) ? bend : 0.0;
    }
}

static bool extend_prescribed(const edges *s, const ss_mesh *given,
                              const ss_quadratic_raised *raised, const ss_prescribed *set,
                              ss_arena *arena, ss_prescribed *out)
{
    patch p;
    *out = *set;
    out->node = extend(s, raised, set->node, set->node_count, arena, &out->node_count);
    out->displacement = ss_arena_get(arena, (size_t)out->node_count, sizeof *out->displacement);
    const bool is_good = patch_init(&p, s, set) && out->node && out->displacement;
    for (int32_t i = 0; is_good && i < out->node_count; ++i) {
        if (i < set->node_count) {
            ss_copy3(out->displacement[i], set->displacement[i]);
        } else {
            prescribe_edge(&p, given, out->node[i] - s->node_count, out->displacement[i]);
        }
    }
    patch_fini(&p);
    return is_good;
}

/* ---- the plan ---- */

static bool extend_plan(const edges *s, const ss_model_plan *plan, ss_arena *arena,
                        ss_quadratic_raised *raised)
{
    raised->plan = *plan;
    raised->plan.mesh = &raised->mesh;
    if (plan->mesh->middle) {
        return true;
    }
    uint8_t *fixed = ss_arena_get(arena, (size_t)raised->mesh.node_count, 1);
    ss_load *load = ss_arena_get(arena, (size_t)plan->load_count, sizeof *load);
    ss_prescribed *prescribed =
        ss_arena_get(arena, (size_t)plan->prescribed_count, sizeof *prescribed);
    bool is_good = fixed && load && prescribed;
    if (is_good) {
        memcpy(fixed, plan->fixed, (size_t)s->node_count);
        spread_bits(s, raised, fixed);
    }
    for (int32_t k = 0; is_good && k < plan->load_count; ++k) {
        load[k] = plan->load[k];
        load[k].node = extend(s, raised, plan->load[k].node, plan->load[k].node_count, arena,
                              &load[k].node_count);
        is_good = load[k].node != NULL;
    }
    for (int32_t k = 0; is_good && k < plan->prescribed_count; ++k) {
        is_good =
            extend_prescribed(s, plan->mesh, raised, &plan->prescribed[k], arena, &prescribed[k]);
    }
    raised->plan.fixed = fixed;
    raised->plan.load = load;
    raised->plan.prescribed = prescribed;
    return is_good;
}

/* ---- all of it ---- */

static bool make_mesh(const ss_mesh *given, edges *s, ss_arena *arena, ss_quadratic_raised *out,
                      bool *out_is_own)
{
    const size_t elements = (size_t)given->tetrahedron_count;
    out->node = ss_arena_get(arena, elements, sizeof *out->node);
    if (!out->node) {
        return false;
    }
    for (int32_t t = 0; t < given->tetrahedron_count; ++t) {
        const int32_t *c = given->tetrahedron[t];
        memcpy(out->node[t], c, 4 * sizeof *c);
        for (int k = 0; k < SS_QUADRATIC_SIDES; ++k) {
            const int32_t e = add(s, c[ends[k][0]], c[ends[k][1]]);
            s->node[e] = given->middle ? given->middle[t][k] : s->node[e];
            out->node[t][4 + k] = s->node[e];
        }
    }
    const int32_t count = given->node_count + (given->middle ? 0 : s->count);
    const int32_t parts = given->middle ? 1 : 4;
    out->given_count = given->node_count;
    out->is_second_order = given->middle != NULL;
    out->mesh = (ss_mesh){.node_count = count,
                          .triangle_count = parts * given->triangle_count,
                          .tetrahedron_count = given->tetrahedron_count,
                          .tetrahedron = given->tetrahedron,
                          .middle = ss_arena_get(arena, elements, sizeof(int32_t[6])),
                          .file_element = given->file_element,
                          .is_closed = given->is_closed,
                          .position = ss_arena_get(arena, (size_t)count, sizeof(double[3])),
                          .triangle = ss_arena_get(arena, (size_t)(parts * given->triangle_count),
                                                   sizeof(int32_t[3])),
                          .file_node = ss_arena_get(arena, (size_t)count, sizeof(int32_t))};
    if (!out->mesh.middle || !out->mesh.position || !out->mesh.triangle || !out->mesh.file_node) {
        return false;
    }
    for (int32_t t = 0; t < given->tetrahedron_count; ++t) {
        memcpy(out->mesh.middle[t], out->node[t] + 4, sizeof *out->mesh.middle);
    }
    for (int32_t i = 0; i < given->node_count; ++i) {
        ss_copy3(out->mesh.position[i], given->position[i]);
        out->mesh.file_node[i] = ss_mesh_file_node(given, i);
    }
    for (int32_t k = 0; k < s->count; ++k) {
        straight(s, given, k, out->mesh.position[s->node[k]]);
        if (!given->middle) { /* messages name an end */
            out->mesh.file_node[s->node[k]] = ss_mesh_file_node(given, s->low[k]);
        }
    }
    *out_is_own = given->middle || split_surface(given, s, out->mesh.triangle);
    if (given->middle) {
        memcpy(out->mesh.triangle, given->triangle,
               (size_t)given->triangle_count * sizeof *given->triangle);
    }
    return true;
}

softsim_status ss_quadratic_raise(const ss_model_plan *plan, bool is_curved, ss_arena *arena,
                                  ss_quadratic_raised *out, softsim_error *error)
{
    edges s;
    bool is_own = true;
    *out = (ss_quadratic_raised){0};
    const bool is_good = edges_init(&s, plan->mesh) &&
                         make_mesh(plan->mesh, &s, arena, out, &is_own) &&
                         (!is_own || !is_curved || curve(plan, &s, out)) &&
                         (!is_own || extend_plan(&s, plan, arena, out));
    edges_free(&s);
    if (!is_own) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE, "%s",
                          "fem-quadratic: the surface has an edge that no tetrahedron has: give a "
                          "mesh whose surface is that of its tetrahedra");
        return SOFTSIM_ERROR_SCENE;
    }
    if (out->lost_edge_count > 0) {
        softsim_error_add(
            error, SOFTSIM_ERROR_SCENE,
            "fem-quadratic: object.surface is not near %d edges of the mesh's surface: "
            "no part of it within half of their length; give one of the same body, in "
            "the same units and place",
            out->lost_edge_count);
        return SOFTSIM_ERROR_SCENE;
    }
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}
