/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Sheets. Each side of a triangle gets at most one mate: the other triangle of an edge of two; of
 * an edge of more, sorted by their angle about it, the one across the wedge that is solid. A node
 * is then what corners share that are joined across mates: where they form several fans, each gets
 * a node of its own, moved a little into its own sheet (Gueziec et al. 2001, "Cutting and
 * stitching", with a choice of mates for solids). Where the same two nodes still have two edges,
 * one is divided in the middle.
 *
 * Which wedge is solid: rays along the axes vote by their parity; where they are undecided, the
 * windings tell, that alternate about an edge where solids touch. Before that go patches (bounded
 * by such edges) that are no part of a solid's surface: those with a free border that hang on
 * others without one, and, where an odd number meets, walls that no ray reaches from outside.
 *
 * Generalised winding numbers (Jacobson et al. 2013) were rejected: they need windings that are
 * right.
 */
#include "mesh/leaves.h"
#include "mesh/mend.h"
#include "mesh/tree.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_BUNDLE = 64, PATCH_SAMPLES = 8, RAYS = 6 };

typedef struct patch {
    double area;
    int32_t triangle[PATCH_SAMPLES];
    int32_t count; /* of triangles */
    bool has_border, is_dropped, is_seen, is_looked_at;
} patch;

typedef struct sheets {
    ss_mend *m;
    ss_mesh view;
    ss_mesh_tuples edges;
    bool has_bundles;
    ss_tree tree;
    int64_t visits;
    int32_t *number; /* of the patch of each triangle */
    patch *patch;
    int32_t *mate; /* of each side 3 t + c: another, or -1 */
    bool *is_turned;
    bool *is_inside_out;     /* of each triangle: of a closed sheet around a negative volume */
    int32_t *queue, *corner; /* corner: union-find of corners */
} sheets;

static void sheets_fini(sheets *s)
{
    ss_mesh_tuples_fini(&s->edges);
    ss_tree_fini(&s->tree);
    SS_EACH(ss_memory_free, s->number, s->patch, s->mate, s->is_turned, s->is_inside_out, s->queue,
            s->corner);
    *s = (sheets){0};
}

static bool sheets_init(sheets *s, ss_mend *m)
{
    *s = (sheets){.m = m, .view = ss_mend_view(m), .visits = 400000000};
    const size_t count = (size_t)m->triangle_count;
    s->number = ss_memory_get(count, sizeof *s->number);
    s->patch = ss_memory_get(count, sizeof *s->patch);
    s->mate = ss_memory_get(3 * count, sizeof *s->mate);
    s->is_turned = ss_memory_get(count, sizeof *s->is_turned);
    s->is_inside_out = ss_memory_get(count, sizeof *s->is_inside_out);
    s->queue = ss_memory_get(count, sizeof *s->queue);
    s->corner = ss_memory_get(3 * count, sizeof *s->corner);
    if (s->number == NULL || s->patch == NULL || s->mate == NULL || s->is_turned == NULL ||
        s->is_inside_out == NULL || s->queue == NULL || s->corner == NULL ||
        !ss_mesh_list_triangle_edges(&s->view, &s->edges)) {
        return false;
    }
    for (int64_t i = 0; i < s->edges.count && !s->has_bundles;) {
        const int64_t end = ss_mesh_run_end(&s->edges, i);
        s->has_bundles = end - i > 2;
        i = end;
    }
    return !s->has_bundles || ss_tree_init_triangles(&s->tree, &s->view);
}

/* ---- walls and flaps ---- */

static double area_of(const sheets *s, int32_t t)
{
    const int32_t *node = s->view.triangle[t];
    double normal[3];
    ss_normal3(normal, s->view.position[node[0]], s->view.position[node[1]],
               s->view.position[node[2]]);
    return 0.5 * ss_norm3(normal);
}

static void find_patches(sheets *s)
{
    const int32_t count = s->m->triangle_count;
    ss_mesh_union_init(s->number, count);
    for (int64_t i = 0; i < s->edges.count;) {
        const int64_t end = ss_mesh_run_end(&s->edges, i);
        if (end - i == 2) {
            ss_mesh_union_join(s->number, s->edges.tuple[i].id / 3, s->edges.tuple[i + 1].id / 3);
        }
        i = end;
    }
    for (int32_t t = 0; t < count; ++t) {
        s->number[t] = ss_mesh_union_find(s->number, t);
        patch *p = &s->patch[s->number[t]];
        p->area += area_of(s, t);
        if (p->count < PATCH_SAMPLES) {
            p->triangle[p->count] = t;
        } else if (p->count % 7 == 0) { /* spread over the patch, the same each time */
            p->triangle[p->count / 7 % PATCH_SAMPLES] = t;
        }
        ++p->count;
    }
    for (int64_t i = 0; i < s->edges.count;) {
        const int64_t end = ss_mesh_run_end(&s->edges, i);
        if (end - i == 1) {
            s->patch[s->number[s->edges.tuple[i].id / 3]].has_border = true;
        }
        i = end;
    }
}

/* Does a ray from either side of it reach the outside? */
static bool is_seen(sheets *s, patch *p)
{
    for (int i = 0; i < PATCH_SAMPLES && i < p->count && !p->is_looked_at && !p->is_seen; ++i) {
        const int32_t *node = s->view.triangle[p->triangle[i]];
        double normal[3], middle[3];
        ss_normal3(normal, s->view.position[node[0]], s->view.position[node[1]],
                   s->view.position[node[2]]);
        const double size = sqrt(ss_normalize3(normal));
        ss_scale3(middle, s->view.position[node[0]], 0.3137);
        ss_madd3(middle, middle, 0.3319, s->view.position[node[1]]);
        ss_madd3(middle, middle, 0.3544, s->view.position[node[2]]);
        for (int side = -1; side <= 1; side += 2) {
            double x[3];
            ss_madd3(x, middle, 0.01 * side * size, normal);
            p->is_seen =
                p->is_seen || ss_tree_cast(&s->tree, &s->view, x, &s->visits).free_count > 0;
        }
    }
    p->is_looked_at = true;
    return p->is_seen;
}

/* The patches at an edge that are still there. `is_odd`: how often each, by parity. */
typedef struct bundle {
    patch *patch[MAX_BUNDLE];
    bool is_odd[MAX_BUNDLE];
    int count, sides; /* patches; triangles at the edge */
} bundle;

static void gather_bundle(sheets *s, int64_t begin, int64_t end, bundle *b)
{
    b->count = 0;
    b->sides = 0;
    for (int64_t i = begin; i < end; ++i) {
        patch *p = &s->patch[s->number[s->edges.tuple[i].id / 3]];
        int k = 0;
        while (k < b->count && b->patch[k] != p) {
            ++k;
        }
        if (p->is_dropped || k == MAX_BUNDLE) {
            continue;
        }
        b->is_odd[k] = k < b->count ? !b->is_odd[k] : true;
        b->patch[k] = p;
        b->count += k == b->count;
        ++b->sides;
    }
}

static bool drop_flaps(const bundle *b)
{
    int whole = 0;
    double area = 0.0;
    bool is_any = false;
    for (int k = 0; k < b->count; ++k) {
        if (!(b->patch[k]->has_border && b->is_odd[k])) {
            whole += b->is_odd[k] ? 1 : 2;
            area += b->patch[k]->area;
        }
    }
    for (int k = 0; k < b->count && whole >= 2; ++k) {
        if (b->patch[k]->has_border && b->is_odd[k] && b->patch[k]->area < area) {
            b->patch[k]->is_dropped = true;
            is_any = true;
        }
    }
    return is_any;
}

static bool drop_wall(sheets *s, const bundle *b)
{
    patch *wall = NULL;
    double largest = 0.0;
    for (int k = 0; k < b->count; ++k) {
        patch *p = b->patch[k];
        largest = fmax(largest, p->area);
        if (b->is_odd[k] && (wall == NULL || p->area < wall->area) && !is_seen(s, p)) {
            wall = p;
        }
    }
    if (wall != NULL && wall->area < largest) {
        wall->is_dropped = true;
        return true;
    }
    return false;
}

/* Tells whether anything went. */
static bool drop_patches(sheets *s)
{
    bool is_any = false;
    find_patches(s);
    for (int64_t i = 0; i < s->edges.count;) {
        const int64_t end = ss_mesh_run_end(&s->edges, i);
        bundle b;
        if (end - i > 2) {
            gather_bundle(s, i, end, &b);
            if (b.sides > 2 && drop_flaps(&b)) {
                is_any = true;
                gather_bundle(s, i, end, &b);
            }
            is_any = (b.sides > 2 && b.sides % 2 == 1 && drop_wall(s, &b)) || is_any;
        }
        i = end;
    }
    for (int32_t t = 0; t < s->m->triangle_count && is_any; ++t) {
        if (s->patch[s->number[t]].is_dropped) {
            ss_mesh_add_fault(&s->m->done->flap_triangle, ss_mend_element(s->m, t));
            s->m->triangle[t][0] = -1;
        }
    }
    return is_any;
}

/* ---- mates ---- */

/* An edge of more than two triangles. */
typedef struct fan {
    ss_leaf side[MAX_BUNDLE];
    int count;
    ss_leaf_axis axis;
} fan;

static double wedge_of(const fan *f, int k)
{
    const int next = (k + 1) % f->count;
    return f->side[next].angle - f->side[k].angle + (next == 0 ? 2.0 * SS_PI : 0.0);
}

/* How many rays more than half say that the wedge after side k is solid. */
static int vote(sheets *s, const fan *f, int k)
{
    double height = f->axis.length;
    for (int i = 0; i < f->count; ++i) {
        height = fmin(height, f->side[i].height);
    }
    const double angle = f->side[k].angle + 0.5 * wedge_of(f, k);
    double x[3];
    ss_madd3(x, f->axis.from, 0.4637 * f->axis.length, f->axis.along);
    ss_madd3(x, x, 0.01 * height * cos(angle), f->axis.first);
    ss_madd3(x, x, 0.01 * height * sin(angle), f->axis.second);
    return 2 * ss_tree_cast(&s->tree, &s->view, x, &s->visits).odd_count - RAYS;
}

static void join_sides(sheets *s, const ss_leaf *a, const ss_leaf *b)
{
    s->mate[a->side] = b->side;
    s->mate[b->side] = a->side;
}

/* An even number: sides k and k + 1 for all even or all odd k. The solid lies at growing angles
 * from a descending side, up to an ascending one. */
static void pair_even(sheets *s, const fan *f)
{
    int votes = 0, windings = 0;
    for (int k = 0; k < f->count; ++k) {
        const int sign = k % 2 == 0 ? 1 : -1;
        votes += sign * vote(s, f, k);
        windings += sign * (f->side[k].is_ascending ? -1 : 1);
    }
    /* Each vote is within 6; windings that alternate make up for those that half agree. */
    const bool by_votes = abs(votes) > 3 * abs(windings);
    const int first = (by_votes ? votes : windings) >= 0 ? 0 : 1;
    for (int k = first; k < f->count + first; k += 2) {
        join_sides(s, &f->side[k % f->count], &f->side[(k + 1) % f->count]);
    }
}

/* An odd number, of open sheets: the two that make the flattest pair, again and again. Wound alike,
 * a pair is flat only in the second place. */
static void pair_odd(sheets *s, const fan *f)
{
    for (int pairs = 0; pairs < f->count / 2; ++pairs) {
        int best[2] = {-1, -1};
        double best_angle = INFINITY;
        for (int a = 0; a < f->count; ++a) {
            for (int b = a + 1; b < f->count; ++b) {
                if (s->mate[f->side[a].side] >= 0 || s->mate[f->side[b].side] >= 0) {
                    continue;
                }
                const double bend = fabs(f->side[b].angle - f->side[a].angle - SS_PI);
                const bool is_alike = f->side[a].is_ascending == f->side[b].is_ascending;
                if (bend + (is_alike ? SS_PI : 0.0) < best_angle) {
                    best_angle = bend + (is_alike ? SS_PI : 0.0);
                    best[0] = a;
                    best[1] = b;
                }
            }
        }
        join_sides(s, &f->side[best[0]], &f->side[best[1]]);
    }
}

static void find_mates(sheets *s)
{
    memset(s->mate, 0xff, 3 * (size_t)s->m->triangle_count * sizeof *s->mate);
    for (int64_t i = 0; i < s->edges.count;) {
        const int64_t end = ss_mesh_run_end(&s->edges, i);
        if (end - i == 2) {
            s->mate[s->edges.tuple[i].id] = s->edges.tuple[i + 1].id;
            s->mate[s->edges.tuple[i + 1].id] = s->edges.tuple[i].id;
        } else if (end - i > 2) {
            fan f = {.count = end - i < MAX_BUNDLE ? (int)(end - i) : MAX_BUNDLE};
            ss_mesh_sort_leaves(&s->view, &s->edges, i, f.count, &f.axis, f.side);
            ss_mesh_add_fault(&s->m->done->parted_edge,
                              ss_mend_node(s->m, s->edges.tuple[i].node[0]));
            (f.count % 2 == 0 ? pair_even : pair_odd)(s, &f);
        }
        i = end;
    }
}

/* ---- winding ---- */

/* Are the two wound against each other, once turned? */
static bool is_against(const sheets *s, int32_t a, int32_t b)
{
    const bool same =
        ss_mesh_edge_is_ascending(&s->view, a) == ss_mesh_edge_is_ascending(&s->view, b);
    return same != (s->is_turned[a / 3] != s->is_turned[b / 3]);
}

static double six_volumes(const sheets *s, int32_t t)
{
    const int32_t *node = s->view.triangle[t];
    const double volume = ss_six_volumes3(s->view.position[0], s->view.position[node[0]],
                                          s->view.position[node[1]], s->view.position[node[2]]);
    return s->is_turned[t] ? -volume : volume;
}

/* Floods a sheet from `seed`; turns the fewer of its triangles. */
static void flood(sheets *s, int32_t seed, bool *is_reached)
{
    int32_t count = 1, turned = 0;
    bool is_closed = true;
    double volume = 0.0;
    s->queue[0] = seed;
    is_reached[seed] = true;
    for (int32_t i = 0; i < count; ++i) {
        const int32_t t = s->queue[i];
        turned += s->is_turned[t];
        volume += six_volumes(s, t);
        for (int32_t id = 3 * t; id < 3 * t + 3; ++id) {
            const int32_t other = s->mate[id];
            is_closed = is_closed && other >= 0;
            if (other >= 0 && !is_reached[other / 3]) {
                is_reached[other / 3] = true;
                s->is_turned[other / 3] = is_against(s, id, other);
                s->queue[count++] = other / 3;
            }
        }
    }
    const bool turns_all = 2 * (int64_t)turned > count;
    for (int32_t i = 0; i < count; ++i) {
        s->is_turned[s->queue[i]] ^= turns_all;
        s->is_inside_out[s->queue[i]] = is_closed && (turns_all ? volume > 0.0 : volume < 0.0);
    }
}

/* Sides of a triangle that is turned change places: 0 and 2, as its nodes 1 and 2 do. */
static int32_t turned_side(const sheets *s, int32_t id)
{
    return id < 0 || !s->is_turned[id / 3] ? id : id / 3 * 3 + 2 - id % 3;
}

static bool wind(sheets *s)
{
    const int32_t count = s->m->triangle_count;
    bool *is_reached = ss_memory_get((size_t)count, sizeof *is_reached);
    int32_t *mate = ss_memory_get(3 * (size_t)count, sizeof *mate);
    if (is_reached == NULL || mate == NULL) {
        SS_EACH(ss_memory_free, is_reached, mate);
        return false;
    }
    for (int32_t t = 0; t < count; ++t) {
        if (!is_reached[t]) {
            flood(s, t, is_reached);
        }
    }
    for (int32_t id = 0; id < 3 * count; ++id) {
        const int32_t other = s->mate[id];
        if (other >= 0 && is_against(s, id, other)) {
            s->mate[id] = s->mate[other] = -1;
            ss_mesh_add_fault(&s->m->done->cut_edge,
                              ss_mend_node(s->m, s->view.triangle[id / 3][id % 3]));
        }
    }
    for (int32_t id = 0; id < 3 * count; ++id) {
        mate[turned_side(s, id)] = turned_side(s, s->mate[id]);
    }
    for (int32_t t = 0; t < count; ++t) {
        int32_t *node = s->m->triangle[t];
        const int32_t second = node[1];
        node[1] = s->is_turned[t] ? node[2] : second;
        node[2] = s->is_turned[t] ? second : node[2];
    }
    memcpy(s->mate, mate, 3 * (size_t)count * sizeof *mate);
    SS_EACH(ss_memory_free, is_reached, mate);
    return true;
}

/* ---- nodes ---- */

static int32_t next_corner(int32_t id)
{
    return id / 3 * 3 + (id % 3 + 1) % 3;
}

/* What a node of a sheet is moved by. */
typedef struct move {
    double normal[3], inward[3];
    int32_t next; /* the next node that was the same, -1 */
    bool is_parted;
} move;

/* Gives each fan a node; `kept`: the fan that keeps a node's number, by its lowest corner. */
static bool part_nodes(sheets *s, int32_t *kept)
{
    ss_mend *m = s->m;
    const int32_t corners = 3 * m->triangle_count;
    memset(kept, 0xff, (size_t)m->node_count * sizeof *kept);
    ss_mesh_union_init(s->corner, corners);
    for (int32_t id = 0; id < corners; ++id) {
        const int32_t other = s->mate[id];
        if (other > id) {
            ss_mesh_union_join(s->corner, id, next_corner(other));
            ss_mesh_union_join(s->corner, next_corner(id), other);
        }
    }
    for (int32_t c = 0; c < corners; ++c) {
        int32_t *node = &m->triangle[c / 3][c % 3];
        const int32_t root = ss_mesh_union_find(s->corner, c);
        if (root != c) {
            *node = m->triangle[root / 3][root % 3]; /* lower, so settled */
        } else if (kept[*node] < 0) {
            kept[*node] = root;
        } else {
            ss_mesh_add_fault(&m->done->parted_node, ss_mend_node(m, *node));
            /* The position moves as the array grows. */
            double x[3];
            ss_copy3(x, m->position[*node]);
            if (!ss_mend_add_node(m, x, m->node_origin[*node], node)) {
                return false;
            }
        }
    }
    return true;
}

static void add_corner(const ss_mend *m, const int32_t *node, int k, bool is_inside_out, move *of)
{
    double u[3], v[3], normal[3];
    ss_sub3(u, m->position[node[(k + 1) % 3]], m->position[node[k]]);
    ss_sub3(v, m->position[node[(k + 2) % 3]], m->position[node[k]]);
    ss_cross3(normal, u, v);
    const double sine = ss_normalize3(normal);
    const double angle = atan2(sine, ss_dot3(u, v));
    ss_madd3(of->normal, of->normal, is_inside_out ? -angle : angle, normal);
    (void)ss_normalize3(u);
    (void)ss_normalize3(v);
    ss_add3(of->inward, of->inward, u);
    ss_add3(of->inward, of->inward, v);
}

/* Moves the nodes of one place apart: each against its sheet's normal and towards its neighbours.
 */
static void move_apart(ss_mend *m, move *moves, int32_t first)
{
    const double gap = SS_MEND_GAP * m->mean_edge;
    double taken[MAX_BUNDLE][3];
    int count = 0;
    for (int32_t i = first; i >= 0; i = moves[i].next) {
        double way[3];
        ss_scale3(way, moves[i].normal, -1.0);
        const double bent = ss_normalize3(way);
        const double apart = ss_normalize3(moves[i].inward);
        if (!(bent > 0.0) && !(apart > 0.0)) {
            ss_set3(way, 1.0, 0.0, 0.0);
        }
        ss_add3(way, way, moves[i].inward);
        if (!(ss_norm3(way) > 0.1)) { /* a fan that is no cone: its normal alone */
            ss_scale3(way, moves[i].normal, -1.0);
        }
        (void)ss_normalize3(way);
        double by = 1.0;
        for (int k = 0; k < count; ++k) {
            double d[3];
            ss_madd3(d, taken[k], -by, way);
            by += ss_norm3(d) < 0.7 ? 1.0 : 0.0;
        }
        if (count < MAX_BUNDLE) {
            ss_scale3(taken[count++], way, by);
        }
        ss_madd3(m->position[i], m->position[i], by * gap, way);
    }
}

static bool move_nodes(sheets *s, int32_t nodes_before, const int32_t *nodes_from)
{
    ss_mend *m = s->m;
    move *moves = ss_memory_get((size_t)m->node_count, sizeof *moves);
    if (moves == NULL) {
        return false;
    }
    for (int32_t i = 0; i < m->node_count; ++i) {
        moves[i].next = -1;
    }
    for (int32_t i = m->node_count - 1; i >= nodes_before; --i) {
        move *first = &moves[nodes_from[i - nodes_before]];
        moves[i].next = first->next;
        first->next = i;
        first->is_parted = true;
    }
    for (int32_t c = 0; c < 3 * m->triangle_count; ++c) {
        const int32_t *node = m->triangle[c / 3];
        add_corner(m, node, c % 3, s->is_inside_out[c / 3], &moves[node[c % 3]]);
    }
    for (int32_t i = 0; i < nodes_before; ++i) {
        if (moves[i].is_parted) {
            move_apart(m, moves, i);
        }
    }
    ss_memory_free(moves);
    return true;
}

/* ---- two edges of the same nodes ---- */

/* Divides side `id`, and its mate, at a node in the middle. */
static bool divide_side(ss_mend *m, int32_t id, int32_t mate)
{
    const int32_t *node = m->triangle[id / 3];
    const int32_t a = node[id % 3], b = node[(id % 3 + 1) % 3];
    double normal[3], other[3], x[3];
    ss_normal3(normal, m->position[node[0]], m->position[node[1]], m->position[node[2]]);
    (void)ss_normalize3(normal);
    if (mate >= 0) {
        node = m->triangle[mate / 3];
        ss_normal3(other, m->position[node[0]], m->position[node[1]], m->position[node[2]]);
        (void)ss_normalize3(other);
        ss_add3(normal, normal, other);
        (void)ss_normalize3(normal);
    }
    ss_scale3(x, m->position[a], 0.5);
    ss_madd3(x, x, 0.5, m->position[b]);
    ss_madd3(x, x, -SS_MEND_GAP * m->mean_edge, normal);
    int32_t middle;
    if (!ss_mend_add_node(m, x, -1, &middle)) {
        return false;
    }
    for (int k = 0; k < 2; ++k) {
        const int32_t at = k == 0 ? id : mate;
        if (at >= 0) {
            int32_t *triangle = m->triangle[at / 3];
            const int32_t end = triangle[(at % 3 + 1) % 3], third = triangle[(at % 3 + 2) % 3];
            triangle[(at % 3 + 1) % 3] = middle;
            if (!ss_mend_add_triangle(m, middle, end, third, m->origin[at / 3])) {
                return false;
            }
        }
    }
    return true;
}

static bool divide_doubles(sheets *s)
{
    ss_mend *m = s->m;
    ss_mesh view = ss_mend_view(m);
    ss_mesh_tuples edges = {0};
    bool *is_touched = ss_memory_get((size_t)m->triangle_count, sizeof *is_touched);
    bool is_good = is_touched != NULL && ss_mesh_list_triangle_edges(&view, &edges);
    for (int64_t i = 0; i < edges.count && is_good;) {
        const int64_t end = ss_mesh_run_end(&edges, i);
        const int32_t first = edges.tuple[i].id;
        for (int64_t k = i + 1; k < end && is_good; ++k) {
            const int32_t id = edges.tuple[k].id, mate = s->mate[id];
            if (mate == first || (mate >= 0 && mate < id) || is_touched[id / 3] ||
                (mate >= 0 && is_touched[mate / 3])) {
                continue;
            }
            is_touched[id / 3] = true;
            if (mate >= 0) {
                is_touched[mate / 3] = true;
            }
            ss_mesh_add_fault(&m->done->divided_triangle, ss_mend_element(m, id / 3));
            is_good = divide_side(m, id, mate);
        }
        i = end;
    }
    ss_mesh_tuples_fini(&edges);
    ss_memory_free(is_touched);
    return is_good;
}

/* ---- all of it ---- */

static bool part(sheets *s)
{
    ss_mend *m = s->m;
    const int32_t nodes = m->node_count;
    find_mates(s);
    int32_t *kept = ss_memory_get((size_t)nodes, sizeof *kept);
    int32_t(*before)[3] = ss_memory_get((size_t)m->triangle_count, sizeof *before);
    int32_t *from = NULL;
    bool is_good = kept != NULL && before != NULL && wind(s);
    if (is_good) {
        memcpy(before, m->triangle, (size_t)m->triangle_count * sizeof *before);
        is_good = part_nodes(s, kept);
        from = ss_memory_get((size_t)(m->node_count - nodes), sizeof *from);
        is_good = is_good && from != NULL;
    }
    for (int32_t c = 0; c < 3 * m->triangle_count && is_good; ++c) {
        if (m->triangle[c / 3][c % 3] >= nodes) {
            from[m->triangle[c / 3][c % 3] - nodes] = before[c / 3][c % 3];
        }
    }
    is_good =
        is_good && (m->node_count == nodes || move_nodes(s, nodes, from)) && divide_doubles(s);
    SS_EACH(ss_memory_free, kept, before, from);
    return is_good;
}

bool ss_mend_part_sheets(ss_mend *m)
{
    sheets s;
    bool is_good = sheets_init(&s, m);
    while (is_good && s.has_bundles && drop_patches(&s)) {
        sheets_fini(&s);
        ss_mend_drop_triangles(m);
        is_good = sheets_init(&s, m);
    }
    is_good = is_good && part(&s);
    sheets_fini(&s);
    return is_good;
}
