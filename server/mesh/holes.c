/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Holes. The open edges of a surface whose nodes have one fan each form loops, each node once. A
 * small loop is triangulated without new nodes so that the sum of a^2 + b^2 + c^2 over its
 * triangles (sides a, b, c) is least: that is area over quality, 4 sqrt(3) A / (a^2 + b^2 + c^2),
 * of each. By dynamic programming over sub-loops (Barequet & Sharir 1995), O(n^3), n <= 300; no
 * flat triangle, and no edge that the surface has already. What would cross the surface is left
 * open, and what could not be looked at to the end.
 *
 * Small: an opening is where a vessel ends or the body was cut, as often as it is a fault. A hole
 * is filled when its area is a small share of its part's and it is not wide, or when a handful of
 * edges bounds it. Others are the owner's to close.
 */
#include "mesh/mend.h"
#include "mesh/tree.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

enum { MAX_LOOP = 300, FEW_EDGES = 6 };
static const double small_area = 0.05;  /* of the part's */
static const double small_width = 0.34; /* diagonal of the hole's box to the part's */
static const double few_edges_area = 0.25;
/* Parts: volume to area^(3/2); a sphere has 0.094. */
static const double flat_volume = 1e-6;
static const double tiny_area = 1e-6;  /* of the whole */
static const double scrap_area = 1e-2; /* of one or two triangles on their own */

/* Of each connected part. */
typedef struct part {
    double area, volume;
    ss_box box;
    int32_t triangles, first;
    bool is_open, is_dropped;
} part;

typedef struct filler {
    ss_mend *m;
    ss_mesh view;
    ss_mesh_tuples edges;
    int32_t *number; /* of the part of each node */
    part *part;
    int32_t part_count;
    int32_t (*open)[2]; /* the other ends of the open edges of each node, -1: none */
    uint8_t *open_count;
    int32_t *start, *around; /* triangles around each node */
    int32_t *place;          /* of a node in the loop, -1 */
    ss_tree tree;
    /* Of one loop. */
    int32_t loop[MAX_LOOP];
    int count;
    double (*cost)[MAX_LOOP];
    int16_t (*apex)[MAX_LOOP];
    bool (*is_taken)[MAX_LOOP]; /* an edge of the surface already */
} filler;

static void filler_destroy(filler *f)
{
    if (f != NULL) {
        ss_mesh_tuples_fini(&f->edges);
        ss_tree_fini(&f->tree);
        SS_EACH(ss_memory_free, f->number, f->part, f->open, f->open_count, f->start, f->around,
                f->place, f->cost, f->apex, f->is_taken, f);
    }
}

/* ---- parts ---- */

static bool measure_parts(filler *f)
{
    const ss_mesh *v = &f->view;
    f->number = ss_memory_get((size_t)v->node_count, sizeof *f->number);
    f->part_count = f->number != NULL ? ss_mesh_find_parts(v, false, f->number) : -1;
    f->part = f->part_count >= 0 ? ss_memory_get((size_t)f->part_count, sizeof *f->part) : NULL;
    if (f->part == NULL || !ss_mesh_list_triangle_edges(v, &f->edges)) {
        return false;
    }
    for (int32_t p = 0; p < f->part_count; ++p) {
        ss_box_init(&f->part[p].box);
    }
    for (int32_t t = 0; t < v->triangle_count; ++t) {
        const int32_t *node = v->triangle[t];
        part *p = &f->part[f->number[node[0]]];
        double normal[3];
        ss_normal3(normal, v->position[node[0]], v->position[node[1]], v->position[node[2]]);
        p->area += 0.5 * ss_norm3(normal);
        p->first = p->triangles++ == 0 ? t : p->first;
        /* About the part's own first node, so that bodies far off lose no digits. */
        p->volume += ss_six_volumes3(v->position[v->triangle[p->first][0]], v->position[node[0]],
                                     v->position[node[1]], v->position[node[2]]) /
                     6.0;
        for (int k = 0; k < 3; ++k) {
            ss_box_add(&p->box, v->position[node[k]]);
        }
    }
    for (int64_t i = 0; i < f->edges.count;) {
        const int64_t end = ss_mesh_run_end(&f->edges, i);
        part *p = &f->part[f->number[f->edges.tuple[i].node[0]]];
        p->is_open = p->is_open || end - i == 1;
        i = end;
    }
    return true;
}

bool ss_mend_drop_small_parts(ss_mend *m)
{
    filler *f = ss_memory_get(1, sizeof *f);
    if (f == NULL) {
        return false;
    }
    f->m = m;
    f->view = ss_mend_view(m);
    const bool is_good = measure_parts(f);
    double total = 0.0;
    int32_t largest = 0;
    for (int32_t i = 0; i < f->part_count && is_good; ++i) {
        total += f->part[i].area;
        largest = f->part[i].area > f->part[largest].area ? i : largest;
    }
    for (int32_t i = 0; i < f->part_count && is_good; ++i) {
        part *p = &f->part[i];
        const bool is_flat =
            !p->is_open && fabs(p->volume) <= flat_volume * p->area * sqrt(p->area);
        const bool is_scrap = p->is_open && p->triangles <= 2 && p->area <= scrap_area * total;
        if (i != largest && (is_flat || is_scrap || p->area <= tiny_area * total)) {
            p->is_dropped = true;
            ss_mesh_add_fault(&m->done->sliver_part, ss_mend_element(m, p->first));
        }
    }
    for (int32_t t = 0; t < m->triangle_count && is_good; ++t) {
        if (f->part[f->number[m->triangle[t][0]]].is_dropped) {
            m->triangle[t][0] = -1;
        }
    }
    if (is_good) {
        ss_mend_drop_triangles(m);
    }
    filler_destroy(f);
    return is_good;
}

/* ---- loops ---- */

static bool list_open(filler *f)
{
    const ss_mesh *v = &f->view;
    const size_t nodes = (size_t)v->node_count;
    f->open = ss_memory_get(nodes, sizeof *f->open);
    f->open_count = ss_memory_get(nodes, sizeof *f->open_count);
    f->start = ss_memory_get(nodes + 1, sizeof *f->start);
    f->around = ss_memory_get(3 * (size_t)v->triangle_count, sizeof *f->around);
    f->place = ss_memory_get(nodes, sizeof *f->place);
    if (f->open == NULL || f->open_count == NULL || f->start == NULL || f->around == NULL ||
        f->place == NULL) {
        return false;
    }
    memset(f->place, 0xff, nodes * sizeof *f->place);
    for (int64_t i = 0; i < f->edges.count;) {
        const int64_t end = ss_mesh_run_end(&f->edges, i);
        const int32_t *node = f->edges.tuple[i].node;
        for (int k = 0; k < 2 && end - i == 1; ++k) {
            uint8_t *count = &f->open_count[node[k]];
            if (*count < 2) {
                f->open[node[k]][*count] = node[1 - k];
            }
            *count = *count < 3 ? *count + 1 : 3;
        }
        i = end;
    }
    for (int32_t c = 0; c < 3 * v->triangle_count; ++c) {
        ++f->start[v->triangle[c / 3][c % 3] + 1];
    }
    for (int32_t i = 0; i < v->node_count; ++i) {
        f->start[i + 1] += f->start[i];
    }
    for (int32_t c = 3 * v->triangle_count - 1; c >= 0; --c) {
        f->around[--f->start[v->triangle[c / 3][c % 3] + 1]] = c / 3;
    }
    /* start[n + 1] is now where n begins. */
    memmove(f->start, f->start + 1, nodes * sizeof *f->start);
    f->start[nodes] = 3 * v->triangle_count;
    return true;
}

/* Collects the loop through `first`, and takes it out of what is open; false when it is no simple
 * loop, or too long. */
static bool collect(filler *f, int32_t first)
{
    int32_t before = -1, at = first;
    f->count = 0;
    while (f->open_count[at] == 2) {
        if (f->count < MAX_LOOP) {
            f->loop[f->count] = at;
        }
        ++f->count;
        f->open_count[at] = 0;
        const int32_t next = f->open[at][0] != before ? f->open[at][0] : f->open[at][1];
        before = at;
        at = next;
    }
    return at == first && f->count >= 3 && f->count <= MAX_LOOP;
}

/* Has a triangle the directed edge from a to b? */
static bool has_directed_edge(const filler *f, int32_t a, int32_t b)
{
    for (int32_t i = f->start[a]; i < f->start[a + 1]; ++i) {
        const int32_t *node = f->view.triangle[f->around[i]];
        for (int k = 0; k < 3; ++k) {
            if (node[k] == a && node[(k + 1) % 3] == b) {
                return true;
            }
        }
    }
    return false;
}

/* Does a triangle of the surface have all three already? */
static bool has_triangle(const filler *f, int32_t a, int32_t b, int32_t c)
{
    for (int32_t i = f->start[a]; i < f->start[a + 1]; ++i) {
        const int32_t *node = f->view.triangle[f->around[i]];
        bool has_b = false, has_c = false;
        for (int k = 0; k < 3; ++k) {
            has_b = has_b || node[k] == b;
            has_c = has_c || node[k] == c;
        }
        if (has_b && has_c) {
            return true;
        }
    }
    return false;
}

/* Reverses the loop where it runs as the triangles beside it do. */
static void turn_loop(filler *f)
{
    if (has_directed_edge(f, f->loop[0], f->loop[1])) {
        for (int i = 0; i < f->count / 2; ++i) {
            const int32_t swapped = f->loop[i];
            f->loop[i] = f->loop[f->count - 1 - i];
            f->loop[f->count - 1 - i] = swapped;
        }
    }
}

static void mark_taken(filler *f)
{
    for (int i = 0; i < f->count; ++i) {
        memset(f->is_taken[i], 0, (size_t)f->count * sizeof f->is_taken[i][0]);
        f->place[f->loop[i]] = i;
    }
    for (int i = 0; i < f->count; ++i) {
        for (int32_t k = f->start[f->loop[i]]; k < f->start[f->loop[i] + 1]; ++k) {
            for (int c = 0; c < 3; ++c) {
                const int32_t other = f->place[f->view.triangle[f->around[k]][c]];
                if (other >= 0) {
                    f->is_taken[i][other] = true;
                }
            }
        }
    }
    for (int i = 0; i < f->count; ++i) {
        f->place[f->loop[i]] = -1;
        f->is_taken[i][(i + 1) % f->count] = false;
        f->is_taken[(i + 1) % f->count][i] = false;
    }
}

/* Infinite where it may not be, or is `most` or more. */
static double cost_of(const filler *f, int i, int j, int k, double most)
{
    const double *a = f->view.position[f->loop[i]];
    const double *b = f->view.position[f->loop[j]];
    const double *c = f->view.position[f->loop[k]];
    double u[3], v[3], w[3], normal[3];
    ss_sub3(u, b, a);
    ss_sub3(v, c, b);
    ss_sub3(w, a, c);
    const double cost = ss_dot3(u, u) + ss_dot3(v, v) + ss_dot3(w, w);
    if (!(cost < most)) {
        return INFINITY;
    }
    ss_cross3(normal, u, v);
    const double h = f->m->mean_edge;
    const double least = 4.0 * SS_MESH_FLAT_AREA * h * h;
    if (f->is_taken[i][k] || f->is_taken[i][j] || f->is_taken[j][k] ||
        !(0.5 * ss_norm3(normal) > least)) {
        return INFINITY;
    }
    return cost;
}

/* Fills in cost and apex; false where there is no way. */
static bool triangulate(filler *f)
{
    const int n = f->count;
    if (n == 3 && has_triangle(f, f->loop[0], f->loop[1], f->loop[2])) {
        return false;
    }
    for (int i = 0; i + 1 < n; ++i) {
        f->cost[i][i + 1] = 0.0;
    }
    for (int span = 2; span < n; ++span) {
        for (int i = 0; i + span < n; ++i) {
            const int k = i + span;
            f->cost[i][k] = INFINITY;
            for (int j = i + 1; j < k; ++j) {
                const double below = f->cost[i][j] + f->cost[j][k];
                const double budget =
                    f->cost[i][k] - below; /* not a number where both are infinite */
                const double cost = budget > 0.0 ? below + cost_of(f, i, j, k, budget) : INFINITY;
                if (cost < f->cost[i][k]) {
                    f->cost[i][k] = cost;
                    f->apex[i][k] = (int16_t)j;
                }
            }
        }
    }
    return f->cost[0][n - 1] < INFINITY;
}

/* Appends the triangles of the loop. */
static bool put_triangles(filler *f)
{
    int stack[MAX_LOOP][2];
    int depth = 0;
    stack[depth][0] = 0;
    stack[depth++][1] = f->count - 1;
    while (depth > 0) {
        const int i = stack[--depth][0], k = stack[depth][1];
        if (k - i < 2) {
            continue;
        }
        const int j = f->apex[i][k];
        if (!ss_mend_add_triangle(f->m, f->loop[i], f->loop[j], f->loop[k], -1)) {
            return false;
        }
        stack[depth][0] = i;
        stack[depth++][1] = j;
        stack[depth][0] = j;
        stack[depth++][1] = k;
    }
    return true;
}

typedef struct crossing {
    const ss_mesh *mesh;
    int32_t own;
    bool is_any;
} crossing;

static void try_crossing(void *what, int32_t other)
{
    crossing *c = what;
    c->is_any = c->is_any || ss_mesh_triangles_cross(c->mesh, c->own, other);
}

/* Of the triangles from `first` on: is the hole small, and do they cross nothing? Where the
 * visits ran out they may. */
static bool may_stay(filler *f, int32_t first)
{
    const ss_mesh view = ss_mend_view(f->m);
    const part *p = &f->part[f->number[f->loop[0]]];
    double area = 0.0, across[3], diagonal[3];
    int64_t visits = 4000000;
    ss_box box;
    ss_box_init(&box);
    crossing c = {.mesh = &view};
    for (int32_t t = first; t < view.triangle_count; ++t) {
        const int32_t *node = view.triangle[t];
        double normal[3];
        ss_box own;
        ss_normal3(normal, view.position[node[0]], view.position[node[1]], view.position[node[2]]);
        area += 0.5 * ss_norm3(normal);
        for (int k = 0; k < 3; ++k) {
            ss_box_add(&box, view.position[node[k]]);
        }
        c.own = t;
        if (ss_box_of_triangle(&view, t, &own)) {
            ss_tree_visit(&f->tree, &own, &visits, try_crossing, &c);
        }
    }
    ss_sub3(across, box.high, box.low);
    ss_sub3(diagonal, p->box.high, p->box.low);
    const bool is_narrow =
        area <= small_area * p->area && ss_norm3(across) <= small_width * ss_norm3(diagonal);
    const bool has_few = f->count <= FEW_EDGES && area <= few_edges_area * p->area;
    return (is_narrow || has_few) && !c.is_any && visits > 0;
}

/* However it is filled: its box is that of its nodes, its area not less than that of the vector of
 * the loop (Newell). So that the O(n^3) of triangulate is spent on holes that may be small. */
static bool may_be_small(const filler *f)
{
    const part *p = &f->part[f->number[f->loop[0]]];
    const double *origin = f->view.position[f->loop[0]];
    double vector[3] = {0.0, 0.0, 0.0}, across[3], diagonal[3];
    ss_box box;
    ss_box_init(&box);
    for (int i = 0; i < f->count; ++i) {
        double normal[3];
        ss_normal3(normal, origin, f->view.position[f->loop[i]],
                   f->view.position[f->loop[(i + 1) % f->count]]);
        ss_add3(vector, vector, normal);
        ss_box_add(&box, f->view.position[f->loop[i]]);
    }
    ss_sub3(across, box.high, box.low);
    ss_sub3(diagonal, p->box.high, p->box.low);
    /* Half the vector is the least area of a surface across the loop; less, for rounding. */
    return f->count <= FEW_EDGES || (0.49 * ss_norm3(vector) <= small_area * p->area &&
                                     ss_norm3(across) <= small_width * ss_norm3(diagonal));
}

static bool make_tables(filler *f)
{
    if (f->cost == NULL) {
        f->cost = ss_memory_get(MAX_LOOP, sizeof *f->cost);
        f->apex = ss_memory_get(MAX_LOOP, sizeof *f->apex);
        f->is_taken = ss_memory_get(MAX_LOOP, sizeof *f->is_taken);
    }
    return f->cost != NULL && f->apex != NULL && f->is_taken != NULL;
}

static bool fill_loop(filler *f)
{
    ss_mend *m = f->m;
    const int32_t before = m->triangle_count;
    if (!may_be_small(f)) {
        return true;
    }
    if (!make_tables(f)) {
        return false;
    }
    turn_loop(f);
    mark_taken(f);
    if (!triangulate(f)) {
        return true;
    }
    if (!put_triangles(f)) {
        return false;
    }
    if (may_stay(f, before)) {
        ss_mesh_add_fault(&m->done->filled_hole, ss_mend_node(m, f->loop[0]));
    } else {
        m->triangle_count = before;
    }
    return true;
}

bool ss_mend_fill_holes(ss_mend *m)
{
    filler *f = ss_memory_get(1, sizeof *f);
    if (f == NULL) {
        return false;
    }
    f->m = m;
    f->view = ss_mend_view(m);
    bool is_good = measure_parts(f) && list_open(f);
    bool is_open = false;
    for (int32_t i = 0; i < f->part_count && is_good; ++i) {
        is_open = is_open || f->part[i].is_open;
    }
    is_good = is_good && (!is_open || ss_tree_init_triangles(&f->tree, &f->view));
    for (int32_t i = 0; i < f->view.node_count && is_good && is_open; ++i) {
        if (f->open_count[i] == 2 && collect(f, i)) {
            /* Triangles may move as they are added. */
            f->view = ss_mend_view(m);
            f->view.triangle_count = f->start[f->view.node_count] / 3;
            is_good = fill_loop(f);
        }
    }
    filler_destroy(f);
    return is_good;
}
