/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Seams. Nodes become one where they lie on each other, where they lie near each other on open
 * edges, and where an edge between them is too short for any model; what that makes flat or double
 * goes. A flat triangle of long sides has a node on its opposite side: without it that side is
 * open, and like any open edge along which others run from node to node it is divided there, which
 * closes the gap.
 *
 * Welding every pair of nodes within a wide tolerance was rejected: it glues thin sheets. Open
 * edges say by themselves that something is missing there.
 */
#include "mesh/mend.h"
#include "mesh/tree.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

#include <stdlib.h>
#include <string.h>

/* Flat triangles of longest sides below this, relative to h, become a point. */
static const double small_triangle = 1e-2;
/* For each open edge, in the mean: many edges along each other, with many nodes, have as many as
 * pairs. Those beyond wait for the next round. */
enum { MOST_JUNCTIONS = 8 };

/* ---- welding ---- */

static double length_of(const ss_mend *m, int32_t a, int32_t b)
{
    double d[3];
    ss_sub3(d, m->position[a], m->position[b]);
    return ss_norm3(d);
}

static double area_of(const ss_mend *m, const int32_t *node)
{
    double normal[3];
    ss_normal3(normal, m->position[node[0]], m->position[node[1]], m->position[node[2]]);
    return 0.5 * ss_norm3(normal);
}

/* Joins the ends of short edges, and flat triangles that are small. */
static void join_short(const ss_mend *m, int32_t *parent)
{
    const double h = m->mean_edge;
    for (int32_t t = 0; t < m->triangle_count; ++t) {
        const int32_t *node = m->triangle[t];
        double longest = 0.0;
        for (int k = 0; k < 3; ++k) {
            const double length = length_of(m, node[k], node[(k + 1) % 3]);
            longest = fmax(longest, length);
            if (length < SS_MEND_REACH * h) {
                ss_mesh_union_join(parent, node[k], node[(k + 1) % 3]);
            }
        }
        if (longest < small_triangle * h && area_of(m, node) <= SS_MESH_FLAT_AREA * h * h) {
            ss_mesh_union_join(parent, node[0], node[1]);
            ss_mesh_union_join(parent, node[0], node[2]);
        }
    }
}

/* Nodes that `is_used` is true of (NULL: all) and that lie within `reach` of another. */
static bool join_near(const ss_mend *m, double reach, const bool *is_used, int32_t *parent)
{
    const ss_mesh mesh = ss_mend_view(m);
    int32_t *twin = ss_memory_get((size_t)m->node_count, sizeof *twin);
    const bool is_good = twin != NULL && ss_mesh_find_twins(&mesh, reach, is_used, twin);
    for (int32_t i = 0; i < m->node_count && is_good; ++i) {
        if (twin[i] >= 0) {
            ss_mesh_union_join(parent, i, twin[i]);
        }
    }
    ss_memory_free(twin);
    return is_good;
}

/* Nodes of edges with one triangle. */
static bool mark_open(const ss_mend *m, bool *is_open)
{
    const ss_mesh mesh = ss_mend_view(m);
    ss_mesh_tuples edges = {0};
    if (!ss_mesh_list_triangle_edges(&mesh, &edges)) {
        return false;
    }
    for (int64_t i = 0; i < edges.count;) {
        const int64_t end = ss_mesh_run_end(&edges, i);
        if (end - i == 1) {
            is_open[edges.tuple[i].node[0]] = true;
            is_open[edges.tuple[i].node[1]] = true;
        }
        i = end;
    }
    ss_mesh_tuples_fini(&edges);
    return true;
}

/* Gives triangles the nodes that theirs were joined to; drops those that have one twice. */
static void weld(ss_mend *m, int32_t *parent)
{
    for (int32_t i = 0; i < m->node_count; ++i) {
        const int32_t to = ss_mesh_union_find(parent, i);
        if (to != i) {
            ss_mesh_add_fault(&m->done->welded_node, ss_mend_node(m, i));
            if (m->node_origin[i] >= 0 && m->node_origin[to] >= 0) {
                ss_mesh_union_join(m->root, m->node_origin[i], m->node_origin[to]);
            }
        }
    }
    for (int32_t t = 0; t < m->triangle_count; ++t) {
        int32_t *node = m->triangle[t];
        for (int k = 0; k < 3; ++k) {
            node[k] = ss_mesh_union_find(parent, node[k]);
        }
        if (node[0] == node[1] || node[1] == node[2] || node[2] == node[0]) {
            ss_mesh_add_fault(&m->done->flat_element, ss_mend_element(m, t));
            node[0] = -1;
        }
    }
    ss_mend_drop_triangles(m);
}

static bool weld_nodes(ss_mend *m)
{
    const ss_mesh mesh = ss_mend_view(m);
    bool *is_used = ss_memory_get((size_t)m->node_count, sizeof *is_used);
    bool *is_open = ss_memory_get((size_t)m->node_count, sizeof *is_open);
    int32_t *parent = ss_memory_get((size_t)m->node_count, sizeof *parent);
    bool is_good = is_used != NULL && is_open != NULL && parent != NULL;
    for (int32_t c = 0; c < 3 * m->triangle_count && is_good; ++c) {
        is_used[m->triangle[c / 3][c % 3]] = true;
    }
    if (is_good) {
        ss_mesh_union_init(parent, m->node_count);
        join_short(m, parent);
        is_good = join_near(m, ss_mesh_twin_reach(&mesh, m->mean_edge), is_used, parent) &&
                  mark_open(m, is_open) &&
                  join_near(m, SS_MEND_REACH * m->mean_edge, is_open, parent);
    }
    if (is_good) {
        weld(m, parent);
    }
    SS_EACH(ss_memory_free, is_used, is_open, parent);
    return is_good;
}

/* ---- flat and double triangles ---- */

static void drop_flat(ss_mend *m)
{
    const double least = SS_MESH_FLAT_AREA * m->mean_edge * m->mean_edge;
    for (int32_t t = 0; t < m->triangle_count; ++t) {
        if (!(area_of(m, m->triangle[t]) > least)) {
            ss_mesh_add_fault(&m->done->flat_element, ss_mend_element(m, t));
            m->triangle[t][0] = -1;
        }
    }
    ss_mend_drop_triangles(m);
}

static bool drop_twins(ss_mend *m)
{
    const ss_mesh mesh = ss_mend_view(m);
    ss_mesh_tuples tuples = {0};
    if (!ss_mesh_list_triangles(&mesh, &tuples)) {
        return false;
    }
    for (int64_t i = 0; i < tuples.count;) {
        const int64_t end = ss_mesh_run_end(&tuples, i);
        for (int64_t k = i + 1; k < end; ++k) {
            ss_mesh_add_fault(&m->done->twin_element, ss_mend_element(m, tuples.tuple[k].id));
            m->triangle[tuples.tuple[k].id][0] = -1;
        }
        i = end;
    }
    ss_mesh_tuples_fini(&tuples);
    ss_mend_drop_triangles(m);
    return true;
}

/* ---- nodes on open edges ---- */

typedef struct junction {
    int32_t edge; /* 3 t + corner */
    int32_t node;
    double share; /* along the edge */
} junction;

typedef struct seam {
    const ss_mend *m;
    ss_mesh_tuples edges;
    int64_t *open; /* the tuples of open edges */
    int32_t open_count;
    ss_box *box;
    int32_t node; /* that is looked at */
    junction *found;
    int32_t found_count, found_room;
    bool is_good;
} seam;

static void try_edge(void *what, int32_t item)
{
    seam *s = what;
    const ss_mend *m = s->m;
    const int32_t id = s->edges.tuple[s->open[item]].id;
    const int32_t *triangle = m->triangle[id / 3];
    const int32_t a = triangle[id % 3], b = triangle[(id % 3 + 1) % 3];
    if (s->node == triangle[0] || s->node == triangle[1] || s->node == triangle[2]) {
        return;
    }
    double along[3], to[3];
    ss_sub3(along, m->position[b], m->position[a]);
    ss_sub3(to, m->position[s->node], m->position[a]);
    const double length2 = ss_dot3(along, along);
    const double share = ss_dot3(along, to) / length2;
    ss_madd3(to, to, -share, along);
    const double reach = SS_MEND_REACH * m->mean_edge;
    const double margin = reach / sqrt(length2);
    const bool is_full = s->found_count >= MOST_JUNCTIONS * s->open_count;
    if (!(share > margin && share < 1.0 - margin && ss_norm3(to) <= reach) || is_full) {
        return;
    }
    junction *grown = ss_memory_grow(s->found, s->found_count, &s->found_room, sizeof *grown);
    s->is_good = s->is_good && grown != NULL;
    if (grown != NULL) {
        s->found = grown;
        s->found[s->found_count++] = (junction){id, s->node, share};
    }
}

static int compare_junctions(const void *left, const void *right)
{
    const junction *a = left, *b = right;
    return ss_order_then(ss_order_int(a->edge / 3, b->edge / 3),
                         ss_order_then(ss_order_int(a->edge, b->edge),
                                       ss_order_then(ss_order_double(a->share, b->share),
                                                     ss_order_int(a->node, b->node))));
}

/* Divides the triangle of the first junction, along one edge; returns behind its junctions of that
 * edge. Those of its other edges wait for the next round. */
static bool divide(ss_mend *m, const junction *j, int32_t count)
{
    const int32_t t = j->edge / 3, corner = j->edge % 3;
    const int32_t a = m->triangle[t][corner], b = m->triangle[t][(corner + 1) % 3];
    const int32_t c = m->triangle[t][(corner + 2) % 3];
    ss_mesh_add_fault(&m->done->divided_triangle, ss_mend_element(m, t));
    const int32_t first[3] = {a, j[0].node, c};
    memcpy(m->triangle[t], first, sizeof first);
    for (int32_t i = 0; i < count; ++i) {
        if (!ss_mend_add_triangle(m, j[i].node, i + 1 < count ? j[i + 1].node : b, c,
                                  m->origin[t])) {
            return false;
        }
    }
    return true;
}

/* Is there an open edge between the two? Tuples of edges are in the order of their nodes. */
static bool is_open_edge(const seam *s, int32_t a, int32_t b)
{
    const int32_t wanted[2] = {a < b ? a : b, a < b ? b : a};
    int32_t low = 0, high = s->open_count;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (ss_order_ints(s->edges.tuple[s->open[middle]].node, wanted, 2) < 0) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < s->open_count && ss_order_ints(s->edges.tuple[s->open[low]].node, wanted, 2) == 0;
}

/* Keeps the junctions of one edge, from `begin` on, that close something: with an open edge to
 * the next along it, or the last. A node that but lies there would be parted from it again. */
static int32_t keep_closing(seam *s, int32_t begin, int32_t end)
{
    const int32_t id = s->found[begin].edge, *triangle = s->m->triangle[id / 3];
    const int32_t before = triangle[id % 3];
    int32_t count = 0;
    bool is_linked = false; /* to what is before it */
    for (int32_t i = begin; i < end; ++i) {
        const junction one = s->found[i];
        const int32_t after = i + 1 < end ? s->found[i + 1].node : triangle[(id % 3 + 1) % 3];
        is_linked = i == begin ? is_open_edge(s, before, one.node) : is_linked;
        const bool links_on = is_open_edge(s, one.node, after);
        if (is_linked || links_on) {
            s->found[begin + count++] = one;
        }
        is_linked = links_on;
    }
    return count;
}

static bool divide_all(ss_mend *m, seam *s)
{
    if (s->found_count > 0) {
        qsort(s->found, (size_t)s->found_count, sizeof *s->found, compare_junctions);
    }
    for (int32_t i = 0; i < s->found_count;) {
        int32_t end = i;
        while (end < s->found_count && s->found[end].edge == s->found[i].edge) {
            ++end;
        }
        const int32_t t = s->found[i].edge / 3, count = keep_closing(s, i, end);
        if (count > 0 && !divide(m, &s->found[i], count)) {
            return false;
        }
        i = end;
        while (count > 0 && i < s->found_count && s->found[i].edge / 3 == t) {
            ++i;
        }
    }
    return true;
}

static bool list_open(seam *s)
{
    const ss_mesh mesh = ss_mend_view(s->m);
    if (!ss_mesh_list_triangle_edges(&mesh, &s->edges)) {
        return false;
    }
    s->open = ss_memory_get((size_t)s->edges.count, sizeof *s->open);
    s->box = ss_memory_get((size_t)s->edges.count, sizeof *s->box);
    for (int64_t i = 0; i < s->edges.count && s->open != NULL && s->box != NULL;) {
        const int64_t end = ss_mesh_run_end(&s->edges, i);
        if (end - i == 1) {
            ss_box *box = &s->box[s->open_count];
            ss_box_init(box);
            ss_box_add(box, mesh.position[s->edges.tuple[i].node[0]]);
            ss_box_add(box, mesh.position[s->edges.tuple[i].node[1]]);
            s->open[s->open_count++] = i;
        }
        i = end;
    }
    return s->open != NULL && s->box != NULL;
}

static bool find_junctions(seam *s)
{
    const ss_mend *m = s->m;
    ss_tree tree;
    bool *is_open = ss_memory_get((size_t)m->node_count, sizeof *is_open);
    if (is_open == NULL || !ss_tree_init(&tree, s->box, s->open_count)) {
        ss_memory_free(is_open);
        return false;
    }
    for (int32_t i = 0; i < s->open_count; ++i) {
        is_open[s->edges.tuple[s->open[i]].node[0]] = true;
        is_open[s->edges.tuple[s->open[i]].node[1]] = true;
    }
    int64_t visits = 400000000;
    for (s->node = 0; s->node < m->node_count; ++s->node) {
        if (is_open[s->node]) {
            const double reach = SS_MEND_REACH * m->mean_edge;
            ss_box box;
            ss_box_init(&box);
            ss_box_add(&box, m->position[s->node]);
            for (int k = 0; k < 3; ++k) {
                box.low[k] -= reach;
                box.high[k] += reach;
            }
            ss_tree_visit(&tree, &box, &visits, try_edge, s);
        }
    }
    ss_tree_fini(&tree);
    ss_memory_free(is_open);
    return s->is_good;
}

static bool close_junctions(ss_mend *m)
{
    seam s = {.m = m, .is_good = true};
    const bool is_good = list_open(&s) && find_junctions(&s) && divide_all(m, &s);
    ss_mesh_tuples_fini(&s.edges);
    SS_EACH(ss_memory_free, s.open, s.box, s.found);
    return is_good;
}

bool ss_mend_stitch(ss_mend *m)
{
    if (!weld_nodes(m)) {
        return false;
    }
    drop_flat(m);
    return drop_twins(m) && close_junctions(m);
}
