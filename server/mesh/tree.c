/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A tree of boxes: items sorted along a Morton curve, and over them a complete binary heap, whose
 * boxes hold those below. A tree split by surface area was rejected: it is built once for a handful
 * of queries per triangle, and this one takes no more than a sort.
 */
#include "mesh/tree.h"

#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_DEPTH = 64 };

/* ---- boxes ---- */

void ss_box_init(ss_box *box)
{
    *box = (ss_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

void ss_box_add(ss_box *box, const double x[3])
{
    for (int k = 0; k < 3; ++k) {
        box->low[k] = fmin(box->low[k], x[k]);
        box->high[k] = fmax(box->high[k], x[k]);
    }
}

bool ss_box_of_triangle(const ss_mesh *mesh, int32_t t, ss_box *out)
{
    ss_box_init(out);
    const int32_t *node = mesh->triangle[t];
    if (!ss_mesh_has_good_nodes(mesh, node, 3)) {
        return false;
    }
    for (int i = 0; i < 3; ++i) {
        if (!ss_mesh_is_place(mesh->position[node[i]])) {
            ss_box_init(out);
            return false;
        }
        ss_box_add(out, mesh->position[node[i]]);
    }
    return true;
}

static void merge(ss_box *into, const ss_box *from)
{
    for (int k = 0; k < 3; ++k) {
        into->low[k] = fmin(into->low[k], from->low[k]);
        into->high[k] = fmax(into->high[k], from->high[k]);
    }
}

/* ---- the tree ---- */

typedef struct place {
    uint64_t code;
    int32_t item;
} place;

static int compare_places(const void *left, const void *right)
{
    const place *a = left, *b = right;
    return ss_order_then(ss_order_bits(a->code, b->code), ss_order_int(a->item, b->item));
}

static uint64_t spread_bits(uint64_t value)
{
    uint64_t out = 0;
    for (int bit = 0; bit < 20; ++bit) {
        out |= (value >> bit & 1) << (3 * bit);
    }
    return out;
}

static uint64_t code_of(const ss_box *all, const ss_box *one)
{
    uint64_t code = 0;
    for (int k = 0; k < 3; ++k) {
        const double width = all->high[k] - all->low[k];
        const double share =
            width > 0.0 ? (0.5 * one->low[k] + 0.5 * one->high[k] - all->low[k]) / width : 0.0;
        code |= spread_bits((uint64_t)(fmin(fmax(share, 0.0), 1.0) * 1048575.0)) << k;
    }
    return code;
}

static void fill(ss_tree *t, const ss_box *box, int32_t count, place *places)
{
    ss_box all;
    ss_box_init(&all);
    for (int32_t i = 0; i < count; ++i) {
        if (box[i].low[0] <= box[i].high[0]) {
            places[t->count++].item = i;
            merge(&all, &box[i]);
        }
    }
    for (int32_t i = 0; i < t->count; ++i) {
        places[i].code = code_of(&all, &box[places[i].item]);
    }
    if (t->count > 0) {
        qsort(places, (size_t)t->count, sizeof *places, compare_places);
    }
    for (int32_t i = 0; i < t->leaf_count; ++i) {
        ss_box_init(&t->box[t->leaf_count + i]);
        if (i < t->count) {
            t->item[i] = places[i].item;
            t->box[t->leaf_count + i] = box[places[i].item];
        }
    }
    for (int32_t i = t->leaf_count - 1; i > 0; --i) {
        t->box[i] = t->box[2 * i];
        merge(&t->box[i], &t->box[2 * i + 1]);
    }
}

bool ss_tree_init(ss_tree *tree, const ss_box *box, int32_t count)
{
    *tree = (ss_tree){.leaf_count = 1};
    while (tree->leaf_count < count) {
        tree->leaf_count *= 2;
    }
    place *places = ss_memory_get((size_t)count, sizeof *places);
    tree->item = ss_memory_get((size_t)count, sizeof *tree->item);
    tree->box = ss_memory_get(2 * (size_t)tree->leaf_count, sizeof *tree->box);
    const bool is_good = places != NULL && tree->item != NULL && tree->box != NULL;
    if (is_good) {
        fill(tree, box, count, places);
    }
    ss_memory_free(places);
    if (!is_good) {
        ss_tree_fini(tree);
    }
    return is_good;
}

bool ss_tree_init_triangles(ss_tree *tree, const ss_mesh *mesh)
{
    *tree = (ss_tree){0};
    ss_box *box = ss_memory_get((size_t)mesh->triangle_count, sizeof *box);
    bool is_good = box != NULL;
    for (int32_t i = 0; i < mesh->triangle_count && is_good; ++i) {
        (void)ss_box_of_triangle(mesh, i, &box[i]);
    }
    is_good = is_good && ss_tree_init(tree, box, mesh->triangle_count);
    ss_memory_free(box);
    return is_good;
}

void ss_tree_fini(ss_tree *tree)
{
    SS_EACH(ss_memory_free, tree->item, tree->box, tree->label);
    *tree = (ss_tree){0};
}

bool ss_tree_set_labels(ss_tree *tree, const int32_t *label)
{
    enum { NO_ITEM = -2 };
    tree->label = ss_memory_get(2 * (size_t)tree->leaf_count, sizeof *tree->label);
    for (int32_t i = 0; tree->label != NULL && i < tree->leaf_count; ++i) {
        tree->label[tree->leaf_count + i] = i < tree->count ? label[tree->item[i]] : NO_ITEM;
    }
    for (int32_t i = tree->leaf_count - 1; tree->label != NULL && i > 0; --i) {
        const int32_t left = tree->label[2 * i], right = tree->label[2 * i + 1];
        tree->label[i] = right == NO_ITEM || left == right ? left : -1; /* fills from the left */
    }
    return tree->label != NULL;
}

/* A point, u x v, and what rounding of it makes of a distance of 1, or more. */
typedef struct plane {
    double x[3], normal[3], slack;
} plane;

static void plane_of(const ss_mesh *mesh, int32_t t, plane *out)
{
    const int32_t *node = mesh->triangle[t];
    double u[3], v[3];
    ss_copy3(out->x, mesh->position[node[0]]);
    ss_sub3(u, mesh->position[node[1]], out->x);
    ss_sub3(v, mesh->position[node[2]], out->x);
    ss_cross3(out->normal, u, v);
    out->slack = 1e-9 * ss_norm3(u) * ss_norm3(v);
}

static bool is_cut(const ss_box *box, const plane *p)
{
    double from_middle = 0.0, from_side = 0.0, reach = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double half = 0.5 * box->high[k] - 0.5 * box->low[k];
        const double middle = box->low[k] + half - p->x[k];
        from_middle += p->normal[k] * middle;
        from_side += fabs(p->normal[k]) * half;
        reach += fabs(middle) + half;
    }
    return fabs(from_middle) <= from_side + p->slack * reach;
}

/* `cut`: NULL: no plane. */
static void visit(const ss_tree *tree, const ss_box *box, const plane *cut, int32_t label,
                  int64_t *inout_visits, void (*take)(void *what, int32_t item), void *what)
{
    int32_t stack[MAX_DEPTH];
    int depth = 0;
    stack[depth++] = 1;
    while (depth > 0 && *inout_visits > 0) {
        const int32_t at = stack[--depth];
        --*inout_visits;
        if (!ss_box_overlaps(box, &tree->box[at]) || (label >= 0 && tree->label[at] == label) ||
            (cut != NULL && !is_cut(&tree->box[at], cut))) {
            continue;
        }
        if (at < tree->leaf_count) {
            stack[depth++] = 2 * at + 1;
            stack[depth++] = 2 * at;
        } else {
            take(what, tree->item[at - tree->leaf_count]);
        }
    }
}

void ss_tree_visit(const ss_tree *tree, const ss_box *box, int64_t *inout_visits,
                   void (*take)(void *what, int32_t item), void *what)
{
    visit(tree, box, NULL, -1, inout_visits, take, what);
}

void ss_tree_visit_others(const ss_tree *tree, const ss_mesh *mesh, int32_t t, int32_t label,
                          int64_t *inout_visits, void (*take)(void *what, int32_t item), void *what)
{
    ss_box box;
    plane cut;
    if (ss_box_of_triangle(mesh, t, &box)) {
        plane_of(mesh, t, &cut);
        visit(tree, &box, &cut, label, inout_visits, take, what);
    }
}

/* ---- nearest points ---- */

/* The point a + s u + t v. */
static double put(const double x[3], const double a[3], double s, const double u[3], double t,
                  const double v[3], double out[3])
{
    double d[3];
    ss_madd3(out, a, s, u);
    ss_madd3(out, out, t, v);
    ss_sub3(d, x, out);
    return ss_dot3(d, d);
}

double ss_triangle_nearest(const double x[3], const double a[3], const double b[3],
                           const double c[3], double out[3])
{
    double u[3], v[3], p[3];
    ss_sub3(u, b, a);
    ss_sub3(v, c, a);
    ss_sub3(p, x, a);
    const double d1 = ss_dot3(u, p), d2 = ss_dot3(v, p);
    if (d1 <= 0.0 && d2 <= 0.0) {
        return put(x, a, 0.0, u, 0.0, v, out);
    }
    ss_sub3(p, x, b);
    const double d3 = ss_dot3(u, p), d4 = ss_dot3(v, p);
    if (d3 >= 0.0 && d4 <= d3) {
        return put(x, a, 1.0, u, 0.0, v, out);
    }
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        return put(x, a, d1 > d3 ? d1 / (d1 - d3) : 0.0, u, 0.0, v, out);
    }
    ss_sub3(p, x, c);
    const double d5 = ss_dot3(u, p), d6 = ss_dot3(v, p);
    if (d6 >= 0.0 && d5 <= d6) {
        return put(x, a, 0.0, u, 1.0, v, out);
    }
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        return put(x, a, 0.0, u, d2 > d6 ? d2 / (d2 - d6) : 0.0, v, out);
    }
    const double va = d3 * d6 - d5 * d4;
    const double to_c = d4 - d3, to_b = d5 - d6;
    if (va <= 0.0 && to_c >= 0.0 && to_b >= 0.0) {
        const double share = to_c + to_b > 0.0 ? to_c / (to_c + to_b) : 0.0;
        return put(x, a, 1.0 - share, u, share, v, out);
    }
    const double sum = va + vb + vc;
    return put(x, a, vb / sum, u, vc / sum, v, out);
}

static double box_distance2(const ss_box *box, const double x[3])
{
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double d = fmax(0.0, fmax(box->low[k] - x[k], x[k] - box->high[k]));
        sum += d * d;
    }
    return sum;
}

double ss_tree_nearest(const ss_tree *tree, const ss_mesh *mesh, const double x[3], double out[3],
                       int32_t *out_triangle)
{
    double best = INFINITY;
    int32_t stack[MAX_DEPTH];
    int depth = 0;
    stack[depth++] = 1;
    while (depth > 0) {
        const int32_t at = stack[--depth];
        if (!(box_distance2(&tree->box[at], x) < best)) {
            continue;
        }
        if (at < tree->leaf_count) {
            const bool left_first =
                box_distance2(&tree->box[2 * at], x) <= box_distance2(&tree->box[2 * at + 1], x);
            stack[depth++] = 2 * at + left_first;
            stack[depth++] = 2 * at + !left_first;
            continue;
        }
        const int32_t t = tree->item[at - tree->leaf_count];
        const int32_t *node = mesh->triangle[t];
        double point[3];
        const double d = ss_triangle_nearest(x, mesh->position[node[0]], mesh->position[node[1]],
                                             mesh->position[node[2]], point);
        if (d < best) {
            best = d;
            ss_copy3(out, point);
            *out_triangle = t;
        }
    }
    return sqrt(best);
}

/* ---- rays ---- */

typedef struct ray {
    const ss_mesh *mesh;
    const double *from;
    int axis;
    double sense;
    int hit_count;
} ray;

static void meet(void *what, int32_t t)
{
    ray *r = what;
    const int32_t *node = r->mesh->triangle[t];
    const int u = (r->axis + 1) % 3, v = (r->axis + 2) % 3;
    double area[3];
    double sum = 0.0;
    double at = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double *p = r->mesh->position[node[(k + 1) % 3]];
        const double *q = r->mesh->position[node[(k + 2) % 3]];
        area[k] =
            (p[u] - r->from[u]) * (q[v] - r->from[v]) - (p[v] - r->from[v]) * (q[u] - r->from[u]);
        sum += area[k];
        at += area[k] * r->mesh->position[node[k]][r->axis];
    }
    const bool is_within = (area[0] > 0.0 && area[1] > 0.0 && area[2] > 0.0) ||
                           (area[0] < 0.0 && area[1] < 0.0 && area[2] < 0.0);
    r->hit_count += is_within && r->sense * (at / sum - r->from[r->axis]) > 0.0;
}

ss_rays ss_tree_cast(const ss_tree *tree, const ss_mesh *mesh, const double x[3],
                     int64_t *inout_visits)
{
    ss_rays rays = {0};
    for (int way = 0; way < 6; ++way) {
        ss_box along;
        ss_box_init(&along);
        ss_box_add(&along, x);
        const int axis = way / 2;
        if (way % 2 == 0) {
            along.high[axis] = INFINITY;
        } else {
            along.low[axis] = -INFINITY;
        }
        ray r = {.mesh = mesh, .from = x, .axis = axis, .sense = way % 2 == 0 ? 1.0 : -1.0};
        ss_tree_visit(tree, &along, inout_visits, meet, &r);
        rays.odd_count += r.hit_count % 2;
        rays.free_count += r.hit_count == 0;
    }
    return rays;
}
