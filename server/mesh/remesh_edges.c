/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What is done at one edge: divided, taken away, flipped; and whether it may be. No operation joins
 * two sheets, turns a triangle over, or makes an edge twice.
 */
#include "mesh/remesher.h"

#include <string.h>

#include "rt/vec.h"

static const double most_turn = 0.5; /* cosine between a triangle's normals before and after */

/* Is the node where features meet, end or bend? */
static bool is_corner(const ss_remesher *r, int32_t node, const ss_ring *g)
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

static int valence(const ss_ring *g)
{
    return g->count + g->is_open;
}

/* How far triangle x b c is from flat: 1 where its angle at x is 3 degrees, or its least height a
 * hundredth of an edge. */
static double openness(const double x[3], const double b[3], const double c[3])
{
    double u[3], v[3], across[3];
    ss_sub3(u, b, x);
    ss_sub3(v, c, x);
    ss_cross3(across, u, v);
    const double size = ss_norm3(across);
    const double flat =
        fmax(0.05 * ss_norm3(u) * ss_norm3(v), 0.01 * fmax(ss_dot3(u, u), ss_dot3(v, v)));
    return flat > 0.0 ? size / flat : 0.0;
}

bool ss_remesh_turns_over(const ss_remesher *r, int32_t side, const double x[3], double as_flat)
{
    double before[3], after[3], u[3], given[3];
    const double *a = r->x[ss_start_of(r, side)];
    const double *b = r->x[ss_end_of(r, side)], *c = r->x[ss_third_of(r, side)];
    ss_normal3(before, a, b, c);
    ss_normal3(after, x, b, c);
    ss_sub3(u, b, x);
    ss_sub3(given, b, a);
    const double size = ss_norm3(after);
    /* Not flat, or hardly flatter where it was. The edge that it shares with the triangle before,
     * and the height of x: not below a third and a fifth of L where they were more; that bounds
     * what comes of many such steps. */
    const double was_open = openness(a, b, c);
    const bool is_flat = !(openness(x, b, c) > (was_open > 1.0 ? 1.0 : as_flat * was_open));
    double across[3];
    ss_sub3(across, c, b);
    const double base = ss_norm3(across);
    const bool is_short = ss_norm3(u) < fmin(r->edge / 3.0, ss_norm3(given)) ||
                          size < fmin(r->edge / 5.0 * base, ss_norm3(before));
    return is_flat || is_short || !(ss_dot3(before, after) > most_turn * ss_norm3(before) * size);
}

bool ss_remesh_divide(ss_remesher *r, int32_t id)
{
    r->is_full = r->triangle_count + 2 > SS_REMESH_MOST_TRIANGLES;
    if (r->is_full || !ss_remesher_make_room(r)) {
        return false;
    }
    const int32_t a = ss_start_of(r, id), b = ss_end_of(r, id), n = r->node_count++;
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
        const int32_t next = ss_next_side(at), q = ss_end_of(r, at), c = ss_third_of(r, at);
        const int32_t made = 3 * r->triangle_count++;
        const int32_t node[3] = {n, q, c};
        memcpy(r->triangle[made / 3], node, sizeof node);
        r->triangle[at / 3][(at % 3 + 1) % 3] = n;
        r->is_feature[made] = is_feature;
        r->is_feature[made + 1] = r->is_feature[next];
        r->is_feature[made + 2] = r->is_feature[next] = false;
        ss_remesher_join(r, made + 1, r->mate[next]);
        ss_remesher_join(r, made + 2, next);
        r->corner[q] = made + 1;
        r->corner[c] = made + 2;
        near[k] = at;
        far[k] = made;
    }
    r->corner[n] = far[0];
    r->mate[near[0]] = r->mate[far[0]] = -1;
    if (mate >= 0) {
        ss_remesher_join(r, near[0], far[1]);
        ss_remesher_join(r, far[0], near[1]);
    }
    return true;
}

/* ---- taking away ---- */

/* Needles side by side shear each other a little as they are joined, and become fewer: they may
 * be so much flatter. */
static const double sheared = 0.8;

/* Has the node more than three neighbours? Looks at no more triangles: a hub has thousands. */
static bool has_more(const ss_remesher *r, int32_t node)
{
    const int32_t first = r->corner[node];
    int32_t at = first;
    int count = 1;
    while (r->mate[ss_last_side(at)] >= 0) {
        at = r->mate[ss_last_side(at)];
        if (at == first) {
            return false;
        }
        if (++count > 3) {
            return true;
        }
    }
    for (at = first; r->mate[at] >= 0 && count <= 3; ++count) {
        at = ss_next_side(r->mate[at]);
    }
    return count + 1 > 3;
}

/* May the start of this side go to its end? */
static bool may_collapse(const ss_remesher *r, int32_t id, const ss_ring *from, const ss_ring *to)
{
    const int32_t a = ss_start_of(r, id), b = ss_end_of(r, id), mate = r->mate[id];
    if (is_corner(r, a, from) || (from->features > 0 && !r->is_feature[id]) ||
        (from->is_open && to->is_open && mate >= 0)) {
        return false;
    }
    int common = 0;
    for (int i = 0; i < from->count; ++i) {
        const int32_t n = ss_end_of(r, from->side[i]), last = ss_third_of(r, from->side[i]);
        const bool is_end = i == from->count - 1 && from->is_open;
        for (int k = 0; k < to->count; ++k) {
            const bool to_end = k == to->count - 1 && to->is_open;
            common +=
                n == ss_end_of(r, to->side[k]) || (to_end && n == ss_third_of(r, to->side[k]));
            common += is_end && (last == ss_end_of(r, to->side[k]) ||
                                 (to_end && last == ss_third_of(r, to->side[k])));
        }
        if (n != b && last != b &&
            (ss_remesh_turns_over(r, from->side[i], r->x[b], sheared) ||
             ss_remesher_length(r, n, b) > SS_REMESH_TOO_LONG * r->edge ||
             ss_remesher_length(r, last, b) > SS_REMESH_TOO_LONG * r->edge)) {
            return false;
        }
    }
    if (common != (mate >= 0 ? 2 : 1)) {
        return false;
    }
    /* What is left of the nodes across must still have three neighbours. */
    return has_more(r, ss_third_of(r, id)) && (mate < 0 || has_more(r, ss_third_of(r, mate)));
}

static void move_to_end(ss_remesher *r, int32_t id, const ss_ring *from)
{
    const int32_t b = ss_end_of(r, id), mate = r->mate[id];
    for (int i = 0; i < from->count; ++i) {
        r->triangle[from->side[i] / 3][from->side[i] % 3] = b;
    }
    for (int k = 0; k < 2; ++k) {
        const int32_t at = k == 0 ? id : mate;
        if (at < 0) {
            continue;
        }
        const int32_t one = ss_next_side(at), other = ss_last_side(at);
        const int32_t p = r->mate[one], q = r->mate[other];
        const bool is_feature = r->is_feature[one] || r->is_feature[other];
        ss_remesher_join(r, p, q);
        for (int i = 0; i < 2; ++i) {
            const int32_t side = i == 0 ? p : q;
            if (side >= 0) {
                r->is_feature[side] = is_feature;
                r->corner[ss_start_of(r, side)] = side;
                r->corner[ss_end_of(r, side)] = ss_next_side(side);
            }
        }
        r->triangle[at / 3][0] = -1;
    }
}

void ss_remesh_collapse(ss_remesher *r, int32_t id)
{
    ss_ring from, to;
    if (ss_remesher_gather(r, ss_start_of(r, id), &from) &&
        ss_remesher_gather(r, ss_end_of(r, id), &to) && may_collapse(r, id, &from, &to)) {
        move_to_end(r, id, &from);
    }
}

/* ---- flipping ---- */

static int excess(const ss_ring *g, int change)
{
    const int off = valence(g) + change - (g->is_open ? 4 : 6);
    return off * off;
}

/* (a, b, c) and (b, a, d) become (c, d, b) and (d, c, a). */
static void change_diagonal(ss_remesher *r, int32_t id)
{
    const int32_t mate = r->mate[id];
    const int32_t a = ss_start_of(r, id), b = ss_end_of(r, id), c = ss_third_of(r, id),
                  d = ss_third_of(r, mate);
    const int32_t side[4] = {ss_next_side(id), ss_last_side(id), ss_next_side(mate),
                             ss_last_side(mate)};
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
        ss_remesher_join(r, place[k], outer[k]);
    }
    r->is_feature[3 * t] = r->is_feature[3 * u] = false;
    ss_remesher_join(r, 3 * t, 3 * u);
    r->corner[a] = 3 * u + 2;
    r->corner[b] = 3 * t + 2;
    r->corner[c] = 3 * t;
    r->corner[d] = 3 * u;
}

static bool are_neighbours(const ss_remesher *r, const ss_ring *g, int32_t other)
{
    for (int i = 0; i < g->count; ++i) {
        if (ss_end_of(r, g->side[i]) == other || ss_third_of(r, g->side[i]) == other) {
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

static bool may_flip(const ss_remesher *r, int32_t id)
{
    const int32_t mate = r->mate[id];
    if (mate < 0 || r->is_feature[id]) {
        return false;
    }
    const int32_t node[4] = {ss_start_of(r, id), ss_end_of(r, id), ss_third_of(r, id),
                             ss_third_of(r, mate)};
    if (node[2] == node[3] ||
        ss_remesher_length(r, node[2], node[3]) >
            fmax(SS_REMESH_TOO_LONG * r->edge, ss_remesher_length(r, node[0], node[1]))) {
        return false;
    }
    const double *a = r->x[node[0]], *b = r->x[node[1]], *c = r->x[node[2]], *d = r->x[node[3]];
    double normal[4][3];
    ss_normal3(normal[0], a, b, c);
    ss_normal3(normal[1], b, a, d);
    ss_normal3(normal[2], c, d, b);
    ss_normal3(normal[3], d, c, a);
    bool is_good = true;
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
    ss_ring g[4];
    for (int k = 0; k < 4 && is_good; ++k) {
        is_good = !r->is_locked[node[k]] && ss_remesher_gather(r, node[k], &g[k]);
    }
    if (!is_good || valence(&g[0]) <= 3 || valence(&g[1]) <= 3 ||
        are_neighbours(r, &g[2], node[3])) {
        return false;
    }
    const int gain = excess(&g[0], 0) + excess(&g[1], 0) + excess(&g[2], 0) + excess(&g[3], 0) -
                     excess(&g[0], -1) - excess(&g[1], -1) - excess(&g[2], 1) - excess(&g[3], 1);
    const double sharp = SS_PI / 9.0; /* 20 degrees: shapes first, neighbours then */
    return before < sharp ? after > before : gain > 0 && after > sharp;
}

void ss_remesh_flip(ss_remesher *r, int32_t id)
{
    if (may_flip(r, id)) {
        change_diagonal(r, id);
    }
}
