/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Triangles of the surface that cross. A tree of boxes over the triangles, sorted along a Morton
 * curve, gives the pairs whose boxes overlap. With the orientation o(a, b, c, d) = sign of
 * (a - d) . (b - d) x (c - d), an edge (p, q) crosses a triangle (a, b, c) when p and q lie
 * strictly on opposite sides of its plane and o(p, q, a, b), o(p, q, b, c), o(p, q, c, a) are not
 * of both signs. Triangles in one plane overlap when no edge of either parts them. Those that share
 * an edge overlap only when they are folded onto each other; of those that share a node the edges
 * opposite it are tested.
 *
 * Signs come from double where the rounding bound of Shewchuk (1997, A estimate) lets them, else
 * from long double with its own bound, below which a point counts as in the plane: so that seams,
 * whose nodes lie on each other exactly, touch and do not cross. Comparing with a tolerance was
 * rejected: it takes near misses for hits or the other way round.
 */
#include "mesh/mesh.h"
#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

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

static bool edge_crosses(const double *p, const double *q, const corners *t)
{
    const int from = orient(t->x[0], t->x[1], t->x[2], p);
    const int to = orient(t->x[0], t->x[1], t->x[2], q);
    if (from * to >= 0) {
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

static bool cross(const ss_mesh *mesh, int32_t s, int32_t t)
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

/* ---- the tree ---- */

typedef struct box {
    double low[3], high[3];
} box;

typedef struct place {
    uint64_t code;
    int32_t triangle;
} place;

/* A heap over the sorted triangles, padded to a power of two: leaf i is node leaf_count + i. */
typedef struct tree {
    place *place;
    box *box;
    bool *is_crossing;
    int32_t count, leaf_count;
    int64_t visits;
} tree;

static int compare_places(const void *left, const void *right)
{
    const place *a = left, *b = right;
    return ss_order_then(ss_order_bits(a->code, b->code), ss_order_int(a->triangle, b->triangle));
}

static uint64_t spread_bits(uint64_t value)
{
    uint64_t out = 0;
    for (int bit = 0; bit < 20; ++bit) {
        out |= (value >> bit & 1) << (3 * bit);
    }
    return out;
}

static bool box_of(const ss_mesh *mesh, int32_t t, box *out)
{
    *out = (box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    const int32_t *node = mesh->triangle[t];
    if (!ss_mesh_has_good_nodes(mesh, node, 3)) {
        return false;
    }
    for (int i = 0; i < 3; ++i) {
        const double *x = mesh->position[node[i]];
        if (!ss_is_finite(x, 3)) {
            return false;
        }
        for (int k = 0; k < 3; ++k) {
            out->low[k] = fmin(out->low[k], x[k]);
            out->high[k] = fmax(out->high[k], x[k]);
        }
    }
    return true;
}

static void merge(box *into, const box *from)
{
    for (int k = 0; k < 3; ++k) {
        into->low[k] = fmin(into->low[k], from->low[k]);
        into->high[k] = fmax(into->high[k], from->high[k]);
    }
}

static void sort_triangles(tree *t, const ss_mesh *mesh)
{
    const box nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    box all = nothing;
    box one;
    for (int32_t i = 0; i < mesh->triangle_count; ++i) {
        if (box_of(mesh, i, &one)) {
            t->place[t->count++].triangle = i;
            merge(&all, &one);
        }
    }
    for (int32_t i = 0; i < t->count; ++i) {
        (void)box_of(mesh, t->place[i].triangle, &one);
        for (int k = 0; k < 3; ++k) {
            const double width = all.high[k] - all.low[k];
            const double share =
                width > 0.0 ? (0.5 * one.low[k] + 0.5 * one.high[k] - all.low[k]) / width : 0.0;
            const double step = fmin(fmax(share, 0.0), 1.0) * 1048575.0;
            t->place[i].code |= spread_bits((uint64_t)step) << k;
        }
    }
    if (t->count > 0) {
        qsort(t->place, (size_t)t->count, sizeof *t->place, compare_places);
    }
    for (int32_t i = 0; i < t->leaf_count; ++i) {
        t->box[t->leaf_count + i] = nothing;
        if (i < t->count) {
            (void)box_of(mesh, t->place[i].triangle, &t->box[t->leaf_count + i]);
        }
    }
    for (int32_t i = t->leaf_count - 1; i > 0; --i) {
        t->box[i] = t->box[2 * i];
        merge(&t->box[i], &t->box[2 * i + 1]);
    }
}

static bool overlap(const box *a, const box *b)
{
    return a->low[0] <= b->high[0] && b->low[0] <= a->high[0] && a->low[1] <= b->high[1] &&
           b->low[1] <= a->high[1] && a->low[2] <= b->high[2] && b->low[2] <= a->high[2];
}

/* Tests leaf `own` against the leaves after it. */
static void find_partners(tree *t, const ss_mesh *mesh, int32_t own)
{
    int32_t stack[64];
    int depth = 0;
    const box mine = t->box[t->leaf_count + own];
    stack[depth++] = 1;
    while (depth > 0 && t->visits < most_visits) {
        const int32_t at = stack[--depth];
        ++t->visits;
        if (!overlap(&mine, &t->box[at])) {
            continue;
        }
        if (at < t->leaf_count) {
            stack[depth++] = 2 * at + 1;
            stack[depth++] = 2 * at;
            continue;
        }
        const int32_t a = t->place[own].triangle;
        const int32_t b = t->place[at - t->leaf_count].triangle;
        if (at - t->leaf_count > own && !(t->is_crossing[a] && t->is_crossing[b]) &&
            cross(mesh, a, b)) {
            t->is_crossing[a] = true;
            t->is_crossing[b] = true;
        }
    }
}

bool ss_mesh_find_crossings(const ss_mesh *mesh, ss_mesh_fault *out_triangle, bool *out_is_complete)
{
    *out_triangle = (ss_mesh_fault){0};
    tree t = {.leaf_count = 1};
    while (t.leaf_count < mesh->triangle_count) {
        t.leaf_count *= 2;
    }
    const size_t triangles = (size_t)mesh->triangle_count;
    t.place = ss_memory_get(triangles, sizeof *t.place);
    t.box = ss_memory_get(2 * (size_t)t.leaf_count, sizeof *t.box);
    t.is_crossing = ss_memory_get(triangles, sizeof *t.is_crossing);
    const bool is_good = t.place != NULL && t.box != NULL && t.is_crossing != NULL;
    if (is_good) {
        sort_triangles(&t, mesh);
        for (int32_t i = 0; i < t.count; ++i) {
            find_partners(&t, mesh, i);
        }
        *out_is_complete = t.visits < most_visits;
        for (int32_t i = 0; i < mesh->triangle_count; ++i) {
            if (t.is_crossing[i]) {
                if (out_triangle->count < SS_MESH_FIRST) {
                    out_triangle->first[out_triangle->count] = i;
                }
                ++out_triangle->count;
            }
        }
    }
    SS_EACH(ss_memory_free, t.place, t.box, t.is_crossing);
    return is_good;
}
