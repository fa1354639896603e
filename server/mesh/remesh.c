/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Isotropic remeshing (Botsch & Kobbelt 2004): again and again, edges longer than 4/3 L are divided
 * in the middle, nodes of edges shorter than 4/5 L go, edges are flipped where that brings the
 * number of neighbours nearer to 6 (4 on a border), and nodes move to the mean of their neighbours
 * in their tangent plane, and back to the nearest point of the surface as it was given. Edges
 * sharper than an angle, and borders, are features: they are divided and shortened along
 * themselves alone, and their nodes do not move.
 *
 * Sides are 3 t + c as everywhere; each has a mate or -1. No operation is done that would join
 * two sheets, turn a triangle over, or make an edge twice. What that cannot see, sheets that come
 * to cross, is looked for after each round: then the round is undone, and done again without the
 * nodes near there.
 *
 * Remeshing from a signed distance was rejected: it closes what is open, and loses features.
 */
#include "mesh/topology.h"
#include "mesh/tree.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

enum { ROUNDS = 10, RETRIES = 4, MAX_RING = 48, MAX_GROUPS = 64 };
static const double too_long = 4.0 / 3.0, too_short = 4.0 / 5.0;
static const double most_turn = 0.5; /* cosine between a triangle's normals before and after */
static const double most_triangles = 4e6;

typedef struct remesher {
    int32_t node_count, node_room, triangle_count, triangle_room;
    double (*x)[3];
    uint64_t *groups; /* a bit for each that the node is in */
    bool *is_locked;
    int32_t *corner; /* a side that starts at the node */
    int32_t (*triangle)[3];
    int32_t *mate;
    bool *is_feature; /* of each side */
    double edge;
    const ss_mesh *given;
    ss_tree tree;
} remesher;

static void remesher_fini(remesher *r)
{
    SS_EACH(ss_memory_free, r->x, r->groups, r->is_locked, r->corner, r->triangle, r->mate,
            r->is_feature);
    ss_tree_fini(&r->tree);
}

/* ---- arrays ---- */

static bool grow(void *array, int32_t count, int32_t room, size_t size)
{
    void **at = array;
    void *larger = ss_memory_get((size_t)room, size);
    if (larger != NULL) {
        if (count > 0) {
            memcpy(larger, *at, (size_t)count * size);
        }
        ss_memory_free(*at);
        *at = larger;
    }
    return larger != NULL;
}

/* Room for one more node and two more triangles. */
static bool make_room(remesher *r)
{
    if (r->node_count + 1 > r->node_room) {
        const int32_t room = 2 * r->node_room + 64, n = r->node_count;
        if (!grow(&r->x, n, room, sizeof *r->x) || !grow(&r->groups, n, room, sizeof *r->groups) ||
            !grow(&r->is_locked, n, room, sizeof *r->is_locked) ||
            !grow(&r->corner, n, room, sizeof *r->corner)) {
            return false;
        }
        r->node_room = room;
    }
    if (r->triangle_count + 2 > r->triangle_room) {
        const int32_t room = 2 * r->triangle_room + 64, n = r->triangle_count;
        if (!grow(&r->triangle, n, room, sizeof *r->triangle) ||
            !grow(&r->mate, n, room, 3 * sizeof *r->mate) ||
            !grow(&r->is_feature, n, room, 3 * sizeof *r->is_feature)) {
            return false;
        }
        r->triangle_room = room;
    }
    return true;
}

static int32_t next_side(int32_t id)
{
    return id / 3 * 3 + (id % 3 + 1) % 3;
}

static int32_t last_side(int32_t id)
{
    return id / 3 * 3 + (id % 3 + 2) % 3;
}

static int32_t start_of(const remesher *r, int32_t id)
{
    return r->triangle[id / 3][id % 3];
}

static int32_t end_of(const remesher *r, int32_t id)
{
    return r->triangle[id / 3][(id % 3 + 1) % 3];
}

static int32_t third_of(const remesher *r, int32_t id)
{
    return r->triangle[id / 3][(id % 3 + 2) % 3];
}

static void join(remesher *r, int32_t a, int32_t b)
{
    if (a >= 0) {
        r->mate[a] = b;
    }
    if (b >= 0) {
        r->mate[b] = a;
    }
}

static double length_of(const remesher *r, int32_t a, int32_t b)
{
    double d[3];
    ss_sub3(d, r->x[a], r->x[b]);
    return ss_norm3(d);
}

/* Packs triangles that are left, and the nodes they use, in order; finds mates and corners. */
static bool rebuild(remesher *r)
{
    int32_t *number = ss_memory_get((size_t)r->node_count, sizeof *number);
    if (number == NULL) {
        return false;
    }
    int32_t kept = 0;
    for (int32_t t = 0; t < r->triangle_count; ++t) {
        if (r->triangle[t][0] >= 0) {
            memmove(r->triangle[kept], r->triangle[t], sizeof r->triangle[0]);
            memmove(r->is_feature + 3 * kept, r->is_feature + 3 * t, 3 * sizeof *r->is_feature);
            for (int k = 0; k < 3; ++k) {
                number[r->triangle[kept][k]] = 1;
            }
            ++kept;
        }
    }
    r->triangle_count = kept;
    int32_t nodes = 0;
    for (int32_t i = 0; i < r->node_count; ++i) {
        if (number[i] != 0) {
            ss_copy3(r->x[nodes], r->x[i]);
            r->groups[nodes] = r->groups[i];
            r->is_locked[nodes] = r->is_locked[i];
            number[i] = nodes++;
        }
    }
    r->node_count = nodes;
    for (int32_t id = 0; id < 3 * kept; ++id) {
        int32_t *node = &r->triangle[id / 3][id % 3];
        *node = number[*node];
        r->corner[*node] = id;
        r->mate[id] = -1;
    }
    ss_memory_free(number);
    const ss_mesh view = {
        .node_count = nodes, .position = r->x, .triangle_count = kept, .triangle = r->triangle};
    ss_mesh_tuples edges = {0};
    if (!ss_mesh_list_triangle_edges(&view, &edges)) {
        return false;
    }
    for (int64_t i = 0; i + 1 < edges.count;) {
        const int64_t end = ss_mesh_run_end(&edges, i);
        if (end - i == 2) {
            join(r, edges.tuple[i].id, edges.tuple[i + 1].id);
        }
        i = end;
    }
    ss_mesh_tuples_fini(&edges);
    return true;
}

/* ---- around a node ---- */

typedef struct ring {
    int32_t side[MAX_RING]; /* that start at the node, in order; from its border where it has one */
    int count;
    bool is_open;
    int features;       /* edges at the node */
    int32_t feature[2]; /* the other ends of the first two */
} ring;

static void note_feature(ring *g, int32_t end)
{
    if (g->features < 2) {
        g->feature[g->features] = end;
    }
    ++g->features;
}

/* False where there are too many. */
static bool gather(const remesher *r, int32_t node, ring *g)
{
    int32_t first = r->corner[node];
    *g = (ring){0};
    for (int k = 0; k < MAX_RING; ++k) {
        if (r->mate[first] < 0) {
            g->is_open = true;
            break;
        }
        first = next_side(r->mate[first]);
        if (first == r->corner[node]) {
            break;
        }
    }
    for (int32_t at = first; g->count < MAX_RING;) {
        g->side[g->count++] = at;
        if (r->is_feature[at]) {
            note_feature(g, end_of(r, at));
        }
        const int32_t before = last_side(at);
        if (r->mate[before] < 0) {
            if (r->is_feature[before]) {
                note_feature(g, start_of(r, before));
            }
            return true;
        }
        at = r->mate[before];
        if (at == first) {
            return true;
        }
    }
    return false;
}

/* Is the node where features meet, end or bend? */
static bool is_corner(const remesher *r, int32_t node, const ring *g)
{
    if (g->features == 0) {
        return false;
    }
    if (g->features != 2) {
        return true;
    }
    double u[3], v[3];
    ss_sub3(u, r->x[g->feature[0]], r->x[node]);
    ss_sub3(v, r->x[g->feature[1]], r->x[node]);
    return ss_dot3(u, v) > -0.7 * ss_norm3(u) * ss_norm3(v);
}

static int valence(const ring *g)
{
    return g->count + g->is_open;
}

/* Would the triangle of this side be the other way up, much flatter or too short, with its start at
 * `x`? */
static bool turns_over(const remesher *r, int32_t side, const double x[3])
{
    double before[3], after[3], u[3], v[3], given[3];
    const double *a = r->x[start_of(r, side)];
    const double *b = r->x[end_of(r, side)], *c = r->x[third_of(r, side)];
    ss_normal3(before, a, b, c);
    ss_normal3(after, x, b, c);
    ss_sub3(u, b, x);
    ss_sub3(v, c, x);
    ss_sub3(given, b, a);
    const double size = ss_norm3(after);
    /* Its angle at x and its least height: not below 3 degrees, or a hundredth of an edge. The edge
     * that it shares with the triangle before, and the height of x: not below a third and a fifth
     * of L where they were more. */
    const bool is_flat = !(size > 0.05 * ss_norm3(u) * ss_norm3(v)) ||
                         !(size > 0.01 * fmax(ss_dot3(u, u), ss_dot3(v, v)));
    double across[3];
    ss_sub3(across, c, b);
    const double base = ss_norm3(across);
    const bool is_short = ss_norm3(u) < fmin(r->edge / 3.0, ss_norm3(given)) ||
                          size < fmin(r->edge / 5.0 * base, ss_norm3(before));
    return is_flat || is_short || !(ss_dot3(before, after) > most_turn * ss_norm3(before) * size);
}

/* ---- operations ---- */

static bool divide(remesher *r, int32_t id)
{
    if (!make_room(r)) {
        return false;
    }
    const int32_t a = start_of(r, id), b = end_of(r, id), n = r->node_count++;
    ss_add3(r->x[n], r->x[a], r->x[b]);
    ss_scale3(r->x[n], r->x[n], 0.5);
    r->groups[n] = r->groups[a] & r->groups[b];
    r->is_locked[n] = false;
    const int32_t mate = r->mate[id];
    const bool is_feature = r->is_feature[id];
    int32_t far[2] = {-1, -1}, near[2] = {-1, -1}; /* the halves of each side */
    for (int k = 0; k < 2; ++k) {
        const int32_t at = k == 0 ? id : mate;
        if (at < 0) {
            continue;
        }
        /* (p, q, c) becomes (p, n, c), and (n, q, c) is new. */
        const int32_t next = next_side(at), q = end_of(r, at), c = third_of(r, at);
        const int32_t made = 3 * r->triangle_count++;
        const int32_t node[3] = {n, q, c};
        memcpy(r->triangle[made / 3], node, sizeof node);
        r->triangle[at / 3][(at % 3 + 1) % 3] = n;
        r->is_feature[made] = is_feature;
        r->is_feature[made + 1] = r->is_feature[next];
        r->is_feature[made + 2] = r->is_feature[next] = false;
        join(r, made + 1, r->mate[next]);
        join(r, made + 2, next);
        r->corner[q] = made + 1;
        r->corner[c] = made + 2;
        near[k] = at;
        far[k] = made;
    }
    r->corner[n] = far[0];
    r->mate[near[0]] = r->mate[far[0]] = -1;
    if (mate >= 0) {
        join(r, near[0], far[1]);
        join(r, far[0], near[1]);
    }
    return true;
}

/* May the start of this side go to its end? */
static bool may_collapse(const remesher *r, int32_t id, const ring *from, const ring *to)
{
    const int32_t a = start_of(r, id), b = end_of(r, id), mate = r->mate[id];
    if (is_corner(r, a, from) || (from->features > 0 && !r->is_feature[id]) ||
        (from->is_open && to->is_open && mate >= 0)) {
        return false;
    }
    int common = 0;
    for (int i = 0; i < from->count; ++i) {
        const int32_t n = end_of(r, from->side[i]), last = third_of(r, from->side[i]);
        const bool is_end = i == from->count - 1 && from->is_open;
        for (int k = 0; k < to->count; ++k) {
            const bool to_end = k == to->count - 1 && to->is_open;
            common += n == end_of(r, to->side[k]) || (to_end && n == third_of(r, to->side[k]));
            common += is_end && (last == end_of(r, to->side[k]) ||
                                 (to_end && last == third_of(r, to->side[k])));
        }
        if (n != b && last != b &&
            (turns_over(r, from->side[i], r->x[b]) || length_of(r, n, b) > too_long * r->edge ||
             length_of(r, last, b) > too_long * r->edge)) {
            return false;
        }
    }
    if (common != (mate >= 0 ? 2 : 1)) {
        return false;
    }
    /* What is left of the nodes across must still have three neighbours. */
    for (int k = 0; k < 2; ++k) {
        ring across;
        const int32_t at = k == 0 ? id : mate;
        if (at >= 0 && (!gather(r, third_of(r, at), &across) || valence(&across) <= 3)) {
            return false;
        }
    }
    return true;
}

static void collapse(remesher *r, int32_t id, const ring *from)
{
    const int32_t b = end_of(r, id), mate = r->mate[id];
    for (int i = 0; i < from->count; ++i) {
        r->triangle[from->side[i] / 3][from->side[i] % 3] = b;
    }
    for (int k = 0; k < 2; ++k) {
        const int32_t at = k == 0 ? id : mate;
        if (at < 0) {
            continue;
        }
        const int32_t one = next_side(at), other = last_side(at);
        const int32_t p = r->mate[one], q = r->mate[other];
        const bool is_feature = r->is_feature[one] || r->is_feature[other];
        join(r, p, q);
        for (int i = 0; i < 2; ++i) {
            const int32_t side = i == 0 ? p : q;
            if (side >= 0) {
                r->is_feature[side] = is_feature;
                r->corner[start_of(r, side)] = side;
                r->corner[end_of(r, side)] = next_side(side);
            }
        }
        r->triangle[at / 3][0] = -1;
    }
}

static int excess(const ring *g, int change)
{
    const int off = valence(g) + change - (g->is_open ? 4 : 6);
    return off * off;
}

/* (a, b, c) and (b, a, d) become (c, d, b) and (d, c, a). */
static void flip(remesher *r, int32_t id)
{
    const int32_t mate = r->mate[id];
    const int32_t a = start_of(r, id), b = end_of(r, id), c = third_of(r, id),
                  d = third_of(r, mate);
    const int32_t side[4] = {next_side(id), last_side(id), next_side(mate), last_side(mate)};
    int32_t outer[4];
    bool is_feature[4];
    for (int k = 0; k < 4; ++k) { /* b-c, c-a, a-d, d-b */
        outer[k] = r->mate[side[k]];
        is_feature[k] = r->is_feature[side[k]];
    }
    const int32_t t = id / 3, u = mate / 3;
    const int32_t first[3] = {c, d, b}, second[3] = {d, c, a};
    memcpy(r->triangle[t], first, sizeof first);
    memcpy(r->triangle[u], second, sizeof second);
    const int32_t place[4] = {3 * t + 2, 3 * u + 1, 3 * u + 2, 3 * t + 1};
    for (int k = 0; k < 4; ++k) {
        r->is_feature[place[k]] = is_feature[k];
        r->mate[place[k]] = -1;
        join(r, place[k], outer[k]);
    }
    r->is_feature[3 * t] = r->is_feature[3 * u] = false;
    join(r, 3 * t, 3 * u);
    r->corner[a] = 3 * u + 2;
    r->corner[b] = 3 * t + 2;
    r->corner[c] = 3 * t;
    r->corner[d] = 3 * u;
}

static bool are_neighbours(const remesher *r, const ring *g, int32_t other)
{
    for (int i = 0; i < g->count; ++i) {
        if (end_of(r, g->side[i]) == other || third_of(r, g->side[i]) == other) {
            return true;
        }
    }
    return false;
}

static double least_angle(const double a[3], const double b[3], const double c[3])
{
    const double *corner[3] = {a, b, c};
    double least = SS_PI;
    for (int k = 0; k < 3; ++k) {
        double u[3], v[3], across[3];
        ss_sub3(u, corner[(k + 1) % 3], corner[k]);
        ss_sub3(v, corner[(k + 2) % 3], corner[k]);
        ss_cross3(across, u, v);
        least = fmin(least, atan2(ss_norm3(across), ss_dot3(u, v)));
    }
    return least;
}

static bool may_flip(const remesher *r, int32_t id)
{
    const int32_t mate = r->mate[id];
    if (mate < 0 || r->is_feature[id]) {
        return false;
    }
    const int32_t node[4] = {start_of(r, id), end_of(r, id), third_of(r, id), third_of(r, mate)};
    ring g[4];
    bool is_good = node[2] != node[3];
    for (int k = 0; k < 4 && is_good; ++k) {
        is_good = !r->is_locked[node[k]] && gather(r, node[k], &g[k]);
    }
    if (!is_good || valence(&g[0]) <= 3 || valence(&g[1]) <= 3 ||
        are_neighbours(r, &g[2], node[3]) ||
        length_of(r, node[2], node[3]) > fmax(too_long * r->edge, length_of(r, node[0], node[1]))) {
        return false;
    }
    const double *a = r->x[node[0]], *b = r->x[node[1]], *c = r->x[node[2]], *d = r->x[node[3]];
    double normal[4][3];
    ss_normal3(normal[0], a, b, c);
    ss_normal3(normal[1], b, a, d);
    ss_normal3(normal[2], c, d, b);
    ss_normal3(normal[3], d, c, a);
    for (int k = 0; k < 4; ++k) {
        is_good = ss_normalize3(normal[k]) > 0.0 && is_good;
    }
    const double before = fmin(least_angle(a, b, c), least_angle(b, a, d));
    const double after = fmin(least_angle(c, d, b), least_angle(d, c, a));
    const double flat = 0.9; /* the pair lies nearly in a plane, before and after */
    is_good =
        is_good && ss_dot3(normal[2], normal[3]) > fmin(flat, ss_dot3(normal[0], normal[1])) &&
        ss_dot3(normal[0], normal[2]) > most_turn && ss_dot3(normal[1], normal[2]) > most_turn &&
        ss_dot3(normal[0], normal[3]) > most_turn;
    const int gain = excess(&g[0], 0) + excess(&g[1], 0) + excess(&g[2], 0) + excess(&g[3], 0) -
                     excess(&g[0], -1) - excess(&g[1], -1) - excess(&g[2], 1) - excess(&g[3], 1);
    const double sharp = SS_PI / 9.0; /* 20 degrees: shapes first, neighbours then */
    return is_good && (before < sharp ? after > before : gain > 0 && after > sharp);
}

/* ---- rounds ---- */

/* Is no other side of its triangle longer? */
static bool is_longest(const remesher *r, int32_t id)
{
    const double own = length_of(r, start_of(r, id), end_of(r, id));
    return own >= length_of(r, end_of(r, id), third_of(r, id)) &&
           own >= length_of(r, third_of(r, id), start_of(r, id));
}

/* Until none is too long, the longest of both triangles first, which keeps angles (Rivara 1984):
 * what moves before would be squeezed against features whose nodes are far apart. */
static bool divide_long(remesher *r)
{
    for (int32_t before = -1; before != r->triangle_count;) {
        before = r->triangle_count;
        for (int32_t id = 0; id < 3 * before; ++id) {
            const int32_t a = start_of(r, id), b = end_of(r, id);
            if (!r->is_locked[a] && !r->is_locked[b] && length_of(r, a, b) > too_long * r->edge &&
                is_longest(r, id) && (r->mate[id] < 0 || is_longest(r, r->mate[id])) &&
                !divide(r, id)) {
                return false;
            }
        }
    }
    return true;
}

static void collapse_short(remesher *r)
{
    for (int32_t id = 0; id < 3 * r->triangle_count; ++id) {
        ring from, to;
        if (r->triangle[id / 3][0] < 0) {
            continue;
        }
        const int32_t a = start_of(r, id), b = end_of(r, id);
        if (!r->is_locked[a] && !r->is_locked[b] && length_of(r, a, b) < too_short * r->edge &&
            gather(r, a, &from) && gather(r, b, &to) && may_collapse(r, id, &from, &to)) {
            collapse(r, id, &from);
        }
    }
}

static void flip_edges(remesher *r)
{
    for (int32_t id = 0; id < 3 * r->triangle_count; ++id) {
        if (r->mate[id] > id && may_flip(r, id)) {
            flip(r, id);
        }
    }
}

/* To the mean of the triangles around it, weighted by area, in its tangent plane, and back to the
 * surface. */
static void smooth_node(remesher *r, int32_t node)
{
    ring g;
    double mean[3] = {0}, normal[3] = {0}, to[3], back[3];
    double area = 0.0;
    if (!gather(r, node, &g) || g.features > 0 || g.is_open) {
        return;
    }
    for (int i = 0; i < g.count; ++i) {
        const double *b = r->x[end_of(r, g.side[i])], *c = r->x[third_of(r, g.side[i])];
        double own[3], middle[3];
        ss_normal3(own, r->x[node], b, c);
        const double weight = ss_norm3(own);
        ss_add3(normal, normal, own);
        ss_add3(middle, b, c);
        ss_add3(middle, middle, r->x[node]);
        ss_madd3(mean, mean, weight / 3.0, middle);
        area += weight;
    }
    if (!(area > 0.0) || !(ss_normalize3(normal) > 0.0)) {
        return;
    }
    ss_scale3(mean, mean, 1.0 / area);
    ss_sub3(to, mean, r->x[node]);
    ss_madd3(to, mean, -ss_dot3(to, normal), normal);
    int32_t t = -1;
    const double off = ss_tree_nearest(&r->tree, r->given, to, back, &t);
    if (!(off < 0.5 * r->edge)) {
        return;
    }
    double there[3];
    const int32_t *n = r->given->triangle[t];
    ss_normal3(there, r->given->position[n[0]], r->given->position[n[1]], r->given->position[n[2]]);
    bool is_good = ss_dot3(there, normal) > 0.0; /* else another sheet's */
    for (int i = 0; i < g.count && is_good; ++i) {
        is_good = !turns_over(r, g.side[i], back);
    }
    if (is_good) {
        ss_copy3(r->x[node], back);
    }
}

static bool run_round(remesher *r)
{
    if (!divide_long(r)) {
        return false;
    }
    collapse_short(r);
    if (!rebuild(r)) {
        return false;
    }
    for (int pass = 0; pass < 2; ++pass) {
        flip_edges(r);
        for (int32_t i = 0; i < r->node_count; ++i) {
            if (!r->is_locked[i]) {
                smooth_node(r, i);
            }
        }
    }
    return rebuild(r);
}

/* ---- undoing ---- */

/* Copies what a round changes. */
static bool copy(const remesher *from, remesher *to)
{
    const size_t nodes = (size_t)from->node_count, triangles = (size_t)from->triangle_count;
    remesher fresh = *to;
    fresh.node_count = fresh.node_room = from->node_count;
    fresh.triangle_count = fresh.triangle_room = from->triangle_count;
    SS_EACH(ss_memory_free, to->x, to->groups, to->is_locked, to->corner, to->triangle, to->mate,
            to->is_feature);
    fresh.x = ss_memory_get(nodes, sizeof *fresh.x);
    fresh.groups = ss_memory_get(nodes, sizeof *fresh.groups);
    fresh.is_locked = ss_memory_get(nodes, sizeof *fresh.is_locked);
    fresh.corner = ss_memory_get(nodes, sizeof *fresh.corner);
    fresh.triangle = ss_memory_get(triangles, sizeof *fresh.triangle);
    fresh.mate = ss_memory_get(triangles, 3 * sizeof *fresh.mate);
    fresh.is_feature = ss_memory_get(triangles, 3 * sizeof *fresh.is_feature);
    *to = fresh;
    if (to->x == NULL || to->groups == NULL || to->is_locked == NULL || to->corner == NULL ||
        to->triangle == NULL || to->mate == NULL || to->is_feature == NULL) {
        return false;
    }
    memcpy(to->x, from->x, nodes * sizeof *to->x);
    memcpy(to->groups, from->groups, nodes * sizeof *to->groups);
    memcpy(to->is_locked, from->is_locked, nodes * sizeof *to->is_locked);
    memcpy(to->corner, from->corner, nodes * sizeof *to->corner);
    memcpy(to->triangle, from->triangle, triangles * sizeof *to->triangle);
    memcpy(to->mate, from->mate, triangles * 3 * sizeof *to->mate);
    memcpy(to->is_feature, from->is_feature, triangles * 3 * sizeof *to->is_feature);
    return true;
}

/* Locks the nodes of `kept` near the triangles of `r` that cross others; how many cross, -1 when
 * out of memory. */
static int32_t lock_crossings(const remesher *r, remesher *kept)
{
    const ss_mesh view = {.node_count = r->node_count,
                          .position = r->x,
                          .triangle_count = r->triangle_count,
                          .triangle = r->triangle};
    bool is_complete;
    bool *is_crossing = ss_memory_get((size_t)r->triangle_count, sizeof *is_crossing);
    ss_box *box = ss_memory_get((size_t)r->triangle_count, sizeof *box);
    int32_t count = 0;
    if (is_crossing == NULL || box == NULL ||
        !ss_mesh_mark_crossings(&view, is_crossing, &is_complete)) {
        count = -1;
    }
    for (int32_t t = 0; t < r->triangle_count && count >= 0; ++t) {
        if (is_crossing[t] && ss_box_of_triangle(&view, t, &box[count])) {
            for (int k = 0; k < 3; ++k) {
                box[count].low[k] -= 1.5 * r->edge;
                box[count].high[k] += 1.5 * r->edge;
            }
            ++count;
        }
    }
    for (int32_t i = 0; i < kept->node_count; ++i) {
        ss_box point;
        ss_box_init(&point);
        ss_box_add(&point, kept->x[i]);
        for (int32_t k = 0; k < count && !kept->is_locked[i]; ++k) {
            kept->is_locked[i] = ss_box_overlaps(&point, &box[k]);
        }
    }
    SS_EACH(ss_memory_free, is_crossing, box);
    return count;
}

/* False when out of memory. */
static bool run_rounds(remesher *r, ss_mesh_remeshing *out)
{
    remesher kept = {0};
    bool is_good = true;
    for (int round = 0; round < ROUNDS && is_good; ++round) {
        is_good = copy(r, &kept);
        for (int retry = 0; is_good; ++retry) {
            is_good = run_round(r);
            const int32_t crossing = is_good ? lock_crossings(r, &kept) : -1;
            is_good = is_good && crossing >= 0;
            if (crossing <= 0) {
                break;
            }
            ++out->undone_rounds;
            is_good = is_good && copy(&kept, r);
            if (retry == RETRIES) {
                round = ROUNDS;
                break;
            }
        }
        out->rounds += round < ROUNDS;
    }
    for (int32_t i = 0; i < r->node_count && is_good; ++i) {
        out->locked_nodes += r->is_locked[i];
    }
    SS_EACH(ss_memory_free, kept.x, kept.groups, kept.is_locked, kept.corner, kept.triangle,
            kept.mate, kept.is_feature);
    return is_good;
}

/* ---- in and out ---- */

static bool take_given(remesher *r, double feature_deg)
{
    const ss_mesh *m = r->given;
    r->node_count = r->node_room = m->node_count;
    r->triangle_count = r->triangle_room = m->triangle_count;
    const size_t nodes = (size_t)m->node_count, triangles = (size_t)m->triangle_count;
    r->x = ss_memory_get(nodes, sizeof *r->x);
    r->groups = ss_memory_get(nodes, sizeof *r->groups);
    r->is_locked = ss_memory_get(nodes, sizeof *r->is_locked);
    r->corner = ss_memory_get(nodes, sizeof *r->corner);
    r->triangle = ss_memory_get(triangles, sizeof *r->triangle);
    r->mate = ss_memory_get(triangles, 3 * sizeof *r->mate);
    r->is_feature = ss_memory_get(triangles, 3 * sizeof *r->is_feature);
    if (r->x == NULL || r->groups == NULL || r->is_locked == NULL || r->corner == NULL ||
        r->triangle == NULL || r->mate == NULL || r->is_feature == NULL) {
        return false;
    }
    memcpy(r->x, m->position, nodes * sizeof *r->x);
    memcpy(r->triangle, m->triangle, triangles * sizeof *r->triangle);
    for (int32_t g = 0; g < m->group_count; ++g) {
        for (int32_t i = 0; i < m->group[g].node_count; ++i) {
            r->groups[m->group[g].node[i]] |= (uint64_t)1 << g;
        }
    }
    if (!rebuild(r)) {
        return false;
    }
    const double least = cos(feature_deg * SS_PI / 180.0);
    for (int32_t id = 0; id < 3 * r->triangle_count; ++id) {
        double normal[2][3];
        const int32_t side[2] = {id, r->mate[id]};
        for (int k = 0; k < 2 && side[1] >= 0; ++k) {
            const int32_t *n = r->triangle[side[k] / 3];
            ss_normal3(normal[k], r->x[n[0]], r->x[n[1]], r->x[n[2]]);
            (void)ss_normalize3(normal[k]);
        }
        r->is_feature[id] = side[1] < 0 || ss_dot3(normal[0], normal[1]) < least;
    }
    return true;
}

static softsim_status give(const remesher *r, ss_mesh **out, softsim_error *error)
{
    const ss_mesh *m = r->given;
    softsim_status status =
        ss_mesh_create(r->node_count, (const double(*)[3])r->x, r->triangle_count,
                       (const int32_t(*)[3])r->triangle, 0, NULL, out, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    (*out)->group = ss_memory_get((size_t)m->group_count, sizeof *(*out)->group);
    for (int32_t g = 0; g < m->group_count && (*out)->group != NULL; ++g) {
        ss_mesh_group *group = &(*out)->group[g];
        memcpy(group->name, m->group[g].name, sizeof group->name);
        group->node = ss_memory_get((size_t)r->node_count, sizeof *group->node);
        for (int32_t i = 0; i < r->node_count && group->node != NULL; ++i) {
            if ((r->groups[i] >> g & 1) != 0) {
                group->node[group->node_count++] = i;
            }
        }
        (*out)->group_count += group->node != NULL;
        status = group->node != NULL ? status : SOFTSIM_ERROR_MEMORY;
    }
    return (*out)->group != NULL ? status : SOFTSIM_ERROR_MEMORY;
}

/* The greatest distance of nodes and middles of triangles of one from the other. */
static bool measure_distance(const ss_mesh *from, const ss_mesh *to, double *inout_most)
{
    ss_tree tree;
    if (!ss_tree_init_triangles(&tree, to)) {
        return false;
    }
    for (int32_t i = 0; i < from->node_count + from->triangle_count; ++i) {
        double x[3], nearest[3];
        int32_t t;
        if (i < from->node_count) {
            ss_copy3(x, from->position[i]);
        } else {
            const int32_t *n = from->triangle[i - from->node_count];
            ss_add3(x, from->position[n[0]], from->position[n[1]]);
            ss_add3(x, x, from->position[n[2]]);
            ss_scale3(x, x, 1.0 / 3.0);
        }
        *inout_most = fmax(*inout_most, ss_tree_nearest(&tree, to, x, nearest, &t));
    }
    ss_tree_fini(&tree);
    return true;
}

static softsim_status refuse(softsim_error *error, const char *why)
{
    softsim_error_add(error, SOFTSIM_ERROR_MESH, "%s", why);
    return SOFTSIM_ERROR_MESH;
}

softsim_status ss_mesh_remesh(const ss_mesh *mesh, double edge, double feature_deg,
                              ss_mesh **out_mesh, ss_mesh_remeshing *out, softsim_error *error)
{
    *out_mesh = NULL;
    *out = (ss_mesh_remeshing){0};
    ss_mesh_report report;
    ss_mesh_finding found[SS_MESH_MAX_FINDINGS];
    ss_mesh_fault crossing;
    bool is_complete, is_refused = false;
    remesher r = {.given = mesh, .edge = edge};
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (mesh->tetrahedron_count > 0) {
        return refuse(error, "it has tetrahedra: give its surface (softsim-mesh convert IN "
                             "surface.obj), and fill that again");
    }
    if (mesh->group_count > MAX_GROUPS) {
        return refuse(error, "it has more than 64 groups: leave those out that are not needed");
    }
    if (ss_mesh_check(mesh, &report) == SOFTSIM_OK &&
        ss_mesh_find_crossings(mesh, &crossing, &is_complete)) {
        const int32_t count = ss_mesh_list_findings(mesh, &report, found);
        for (int32_t i = 0; i < count; ++i) {
            is_refused = is_refused || !found[i].is_harmless;
        }
        if (is_refused || crossing.count > 0) {
            return refuse(error, crossing.count > 0
                                     ? "triangles cross others: move them apart, or join the "
                                       "bodies; softsim-mesh check tells which"
                                     : "mend it first: softsim-mesh convert --repair");
        }
        if (report.area / (0.433 * edge * edge) > most_triangles) {
            return refuse(error, "more than 4 million triangles: give a longer edge");
        }
        status = ss_tree_init_triangles(&r.tree, mesh) && take_given(&r, feature_deg) &&
                         run_rounds(&r, out)
                     ? give(&r, out_mesh, error)
                     : SOFTSIM_ERROR_MEMORY;
    }
    if (status == SOFTSIM_OK && !(measure_distance(mesh, *out_mesh, &out->distance) &&
                                  measure_distance(*out_mesh, mesh, &out->distance))) {
        status = SOFTSIM_ERROR_MEMORY;
    }
    if (status != SOFTSIM_OK) {
        ss_mesh_destroy(out_mesh);
    }
    if (status == SOFTSIM_ERROR_MEMORY) {
        softsim_error_add(error, status, "out of memory while remeshing");
    }
    remesher_fini(&r);
    return status;
}
