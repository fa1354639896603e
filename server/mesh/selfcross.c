/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Triangles of the surface that cross. A tree of boxes over the triangles (tree.h) gives the pairs
 * whose boxes overlap. With the orientation o(a, b, c, d) = sign of
 * (a - d) . (b - d) x (c - d), an edge (p, q) crosses a triangle (a, b, c) when p and q lie
 * strictly on opposite sides of its plane and o(p, q, a, b), o(p, q, b, c), o(p, q, c, a) are not
 * of both signs. Triangles in one plane overlap when no edge of either parts them. Those that share
 * an edge overlap only when they are folded onto each other; of those that share a node the edges
 * opposite it are tested.
 *
 * The boxes of all triangles around one node overlap, which is quadratic in their number. So each
 * triangle at a hub, a node of many, looks in the tree for
 * - those at its hub with its far edge alone, the one opposite the hub. Two that share a node cross
 *   only where the far edge of one meets the other: where they are not in one plane that edge alone
 *   has no node of the other, and where they are a ray from the node into both meets the nearer far
 *   edge within the other triangle.
 * - those at other hubs with its box and its plane, which parts it from most of the fan across a
 * rim (a bipyramid), and passes by its own hub's. Triangles at no hub look for all.
 *
 * Signs come from double where the rounding bound of Shewchuk (1997, A estimate) lets them, else
 * from long double with its own bound, below which a point counts as in the plane: so that seams,
 * whose nodes lie on each other exactly, touch and do not cross. Comparing with a tolerance was
 * rejected: it takes near misses for hits or the other way round.
 */
#include "mesh/mesh.h"
#include "mesh/topology.h"
#include "mesh/tree.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <float.h>

/* Boxes visited; a closed surface needs about a hundred a triangle. */
static const int64_t most_visits = 400000000;

/* ---- orientation ---- */

static int sign_of(double value)
{
    return (value > 0.0) - (value < 0.0);
}

static int orient_long(const double a[3], const double b[3], const double c[3], const double d[3])
{
    long double m[3][3];
    for (int k = 0; k < 3; ++k) {
        m[0][k] = (long double)a[k] - (long double)d[k];
        m[1][k] = (long double)b[k] - (long double)d[k];
        m[2][k] = (long double)c[k] - (long double)d[k];
    }
    long double sum = 0.0L;
    long double size = 0.0L;
    for (int k = 0; k < 3; ++k) {
        const long double left = m[0][k] * m[1][(k + 1) % 3] * m[2][(k + 2) % 3];
        const long double right = m[0][k] * m[1][(k + 2) % 3] * m[2][(k + 1) % 3];
        sum += left - right;
        size += (left < 0.0L ? -left : left) + (right < 0.0L ? -right : right);
    }
    const long double bound = 16.0L * LDBL_EPSILON * size;
    return (sum > bound) - (sum < -bound);
}

static int orient(const double a[3], const double b[3], const double c[3], const double d[3])
{
    double m[3][3];
    ss_sub3(m[0], a, d);
    ss_sub3(m[1], b, d);
    ss_sub3(m[2], c, d);
    double sum = 0.0;
    double size = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double left = m[1][(k + 1) % 3] * m[2][(k + 2) % 3];
        const double right = m[1][(k + 2) % 3] * m[2][(k + 1) % 3];
        sum += m[0][k] * (left - right);
        size += fabs(m[0][k]) * (fabs(left) + fabs(right));
    }
    return fabs(sum) > 8.0 * DBL_EPSILON * size ? sign_of(sum) : orient_long(a, b, c, d);
}

/* ---- two triangles ---- */

typedef struct corners {
    const double *x[3];
} corners;

static bool has_box_at(const corners *t, const double *p, const double *q)
{
    ss_box own, edge;
    ss_box_init(&own);
    ss_box_init(&edge);
    for (int k = 0; k < 3; ++k) {
        ss_box_add(&own, t->x[k]);
    }
    ss_box_add(&edge, p);
    ss_box_add(&edge, q);
    return ss_box_overlaps(&own, &edge);
}

/* Of an edge nearly in the plane all signs are of rounding; its box tells whether it is there. */
static bool edge_crosses(const double *p, const double *q, const corners *t)
{
    const int from = orient(t->x[0], t->x[1], t->x[2], p);
    const int to = orient(t->x[0], t->x[1], t->x[2], q);
    if (from * to >= 0 || !has_box_at(t, p, q)) {
        return false;
    }
    int least = 1;
    int most = -1;
    for (int k = 0; k < 3; ++k) {
        const int side = orient(p, q, t->x[k], t->x[(k + 1) % 3]);
        least = side < least ? side : least;
        most = side > most ? side : most;
    }
    return least >= 0 || most <= 0;
}

/* Is there an edge of a that has a on one side and all of b on the other, or on it? `above` is a
 * point off the plane of both. */
static bool is_parted(const corners *a, const corners *b, const double above[3])
{
    for (int k = 0; k < 3; ++k) {
        const double *p = a->x[k];
        const double *q = a->x[(k + 1) % 3];
        const int own = orient(p, q, above, a->x[(k + 2) % 3]);
        bool parts = own != 0;
        for (int i = 0; i < 3; ++i) {
            parts = parts && own * orient(p, q, above, b->x[i]) <= 0;
        }
        if (parts) {
            return true;
        }
    }
    return false;
}

static bool are_in_one_plane(const corners *a, const corners *b)
{
    for (int k = 0; k < 3; ++k) {
        if (orient(a->x[0], a->x[1], a->x[2], b->x[k]) != 0) {
            return false;
        }
    }
    return true;
}

static bool overlap_in_plane(const corners *a, const corners *b)
{
    double normal[3], above[3];
    ss_normal3(normal, a->x[0], a->x[1], a->x[2]);
    const double size = ss_normalize3(normal);
    if (!(size > 0.0)) {
        return false; /* flat: a fault of its own */
    }
    ss_madd3(above, a->x[0], sqrt(size), normal);
    return !is_parted(a, b, above) && !is_parted(b, a, above);
}

bool ss_mesh_triangles_cross(const ss_mesh *mesh, int32_t s, int32_t t)
{
    corners a;
    corners b;
    int shared = 0;
    bool a_shares[3] = {false, false, false};
    bool b_shares[3] = {false, false, false};
    for (int i = 0; i < 3; ++i) {
        a.x[i] = mesh->position[mesh->triangle[s][i]];
        b.x[i] = mesh->position[mesh->triangle[t][i]];
        for (int k = 0; k < 3; ++k) {
            if (mesh->triangle[s][i] == mesh->triangle[t][k]) {
                ++shared;
                a_shares[i] = true;
                b_shares[k] = true;
            }
        }
    }
    if (shared == 3) {
        return false; /* there twice: a fault of its own */
    }
    if (are_in_one_plane(&a, &b)) {
        return overlap_in_plane(&a, &b);
    }
    if (shared == 2) {
        return false;
    }
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        if ((!a_shares[k] && !a_shares[next] && edge_crosses(a.x[k], a.x[next], &b)) ||
            (!b_shares[k] && !b_shares[next] && edge_crosses(b.x[k], b.x[next], &a))) {
            return true;
        }
    }
    return false;
}

/* ---- all pairs ---- */

/* `first`: of each triangle the lowest of those with its nodes. */
static bool find_first(const ss_mesh *mesh, int32_t *first)
{
    ss_mesh_tuples tuples = {0};
    if (!ss_mesh_list_triangles(mesh, &tuples)) {
        return false;
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        first[t] = t;
    }
    for (int64_t i = 0; i < tuples.count;) {
        const int64_t end = ss_mesh_run_end(&tuples, i);
        for (int64_t k = i; k < end; ++k) {
            first[tuples.tuple[k].id] = tuples.tuple[i].id;
        }
        i = end;
    }
    ss_mesh_tuples_fini(&tuples);
    return true;
}

/* `hub`: of each triangle that of its nodes which has the most triangles, where those are more than
 * HUB; else -1. */
static bool find_hubs(const ss_mesh *mesh, int32_t *hub)
{
    enum { HUB = 64 };
    int32_t *count = ss_memory_get((size_t)mesh->node_count, sizeof *count);
    if (count == NULL) {
        return false;
    }
    for (int32_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const int32_t *node = mesh->triangle[i / 3];
        if (ss_mesh_has_good_nodes(mesh, node, 3)) {
            ++count[node[i % 3]];
        }
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *node = mesh->triangle[t];
        int32_t most = HUB;
        hub[t] = -1;
        for (int k = 0; k < 3 && ss_mesh_has_good_nodes(mesh, node, 3); ++k) {
            if (count[node[k]] > most) {
                most = count[node[k]];
                hub[t] = node[k];
            }
        }
    }
    ss_memory_free(count);
    return true;
}

typedef struct search {
    const ss_mesh *mesh;
    const ss_tree *tree;
    const int32_t *hub;
    bool *is_crossing;
    int64_t visits;
    int32_t own;
} search;

/* Of two at one hub each looks for the other; one at no hub looks for those at hubs; of others the
 * lower number looks. */
static void try_pair(void *what, int32_t other)
{
    search *s = what;
    const int32_t own = s->own;
    const bool looks_down = s->hub[other] >= 0 && (s->hub[own] < 0 || s->hub[own] == s->hub[other]);
    if ((other > own || (other < own && looks_down)) &&
        !(s->is_crossing[own] && s->is_crossing[other]) &&
        ss_mesh_triangles_cross(s->mesh, own < other ? own : other, own < other ? other : own)) {
        s->is_crossing[own] = true;
        s->is_crossing[other] = true;
    }
}

static void try_far_edge(search *s)
{
    const int32_t *node = s->mesh->triangle[s->own];
    ss_box box;
    ss_box_init(&box);
    for (int k = 0; k < 3; ++k) {
        if (node[k] != s->hub[s->own]) {
            ss_box_add(&box, s->mesh->position[node[k]]);
        }
    }
    for (int i = 0; i < 3; ++i) { /* what counts as in the plane may be beside it */
        const double slack = 1e-9 * (fabs(box.low[i]) + fabs(box.high[i]));
        box.low[i] -= slack;
        box.high[i] += slack;
    }
    ss_tree_visit(s->tree, &box, &s->visits, try_pair, s);
}

/* Those that are there already cross what the first of them does. */
bool ss_mesh_mark_crossings(const ss_mesh *mesh, bool *out_is_crossing, bool *out_is_complete)
{
    const int32_t count = mesh->triangle_count;
    ss_tree tree = {0};
    ss_box *box = ss_memory_get((size_t)count, sizeof *box);
    int32_t *first = ss_memory_get((size_t)count, sizeof *first);
    int32_t *hub = ss_memory_get((size_t)count, sizeof *hub);
    bool is_good = box != NULL && first != NULL && hub != NULL && find_first(mesh, first) &&
                   find_hubs(mesh, hub);
    for (int32_t t = 0; t < count && is_good; ++t) {
        if (first[t] != t || !ss_box_of_triangle(mesh, t, &box[t])) {
            ss_box_init(&box[t]);
        }
    }
    is_good = is_good && ss_tree_init(&tree, box, count) && ss_tree_set_labels(&tree, hub);
    search s = {mesh, &tree, hub, out_is_crossing, most_visits, 0};
    for (int32_t t = 0; t < count; ++t) {
        out_is_crossing[t] = false;
    }
    for (int32_t t = 0; t < count && is_good; ++t) {
        s.own = t;
        if (!(box[t].low[0] <= box[t].high[0])) {
            continue;
        }
        if (hub[t] >= 0) {
            try_far_edge(&s);
            ss_tree_visit_others(&tree, mesh, t, hub[t], &s.visits, try_pair, &s);
        } else {
            ss_tree_visit(&tree, &box[t], &s.visits, try_pair, &s);
        }
    }
    for (int32_t t = 0; t < count && is_good; ++t) {
        out_is_crossing[t] = out_is_crossing[first[t]];
    }
    *out_is_complete = s.visits > 0;
    ss_tree_fini(&tree);
    SS_EACH(ss_memory_free, box, first, hub);
    return is_good;
}

bool ss_mesh_find_crossings(const ss_mesh *mesh, ss_mesh_fault *out_triangle, bool *out_is_complete)
{
    *out_triangle = (ss_mesh_fault){0};
    bool *is_crossing = ss_memory_get((size_t)mesh->triangle_count, sizeof *is_crossing);
    const bool is_good =
        is_crossing != NULL && ss_mesh_mark_crossings(mesh, is_crossing, out_is_complete);
    for (int32_t i = 0; i < mesh->triangle_count && is_good; ++i) {
        if (is_crossing[i]) {
            ss_mesh_add_fault(out_triangle, i);
        }
    }
    ss_memory_free(is_crossing);
    return is_good;
}
