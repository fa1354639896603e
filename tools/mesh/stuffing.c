/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Isosurface stuffing, F. Labelle and J. R. Shewchuk, "Isosurface Stuffing: Fast Tetrahedral
 * Meshes with Good Dihedral Angles", SIGGRAPH 2007, uniform version.
 *
 * 1. Body-centred cubic lattice: the corners of cubes of edge a and their centres. Long edges
 *    (length a) join like points along an axis, short ones (sqrt(3)/2 a) a centre and its eight
 *    corners. Every long edge between two centres pierces a face of the cubes; with each of that
 *    face's four sides it spans one tetrahedron, 12 a cube, with angles of 60 and 90 degrees.
 * 2. f at every point. An edge that runs from inside to outside has a cut point on the surface.
 * 3. A point with a cut point nearer than alpha_long a (long edge) or alpha_short sqrt(3)/2 a
 *    (short edge) is moved onto the nearest such, and its edges lose their cut points. With
 *    alpha_long = 0.24999, alpha_short = 0.41189 (the paper's section 4) no angle of step 4 is
 *    below 10.78 or above 164.74 degrees.
 * 4. What of each tetrahedron is inside is cut into tetrahedra: with p points inside, z on the
 *    surface and m outside (p + z + m = 4)
 *      m = 0, p > 0: itself;  p = 1: one;  p = 2, m = 1: a pyramid, two;
 *      p = 3 or p = m = 2: a prism, three.
 *    Tetrahedra that share a face must cut it along the same diagonal: the one at the cut point of
 *    the long side where one of the two cut sides is long; else the face's long edge joins the two
 *    inner points, and the diagonal starts from that of them whose place along the axis is even.
 *    A prism has six ways of being cut (an order of its three columns); of those that agree with
 *    the faces' diagonals the one with the best angles is taken, for the diagonal on the surface
 *    is nobody else's. The rule never closes a circle, in which no order would agree.
 *
 * Delaunay tetrahedra of points in the body were rejected: slivers among them need a second
 * method to be rid of, with no bound on what remains.
 */
#include "stuffing.h"

#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

static const double alpha_long = 0.24999;
static const double alpha_short = 0.41189;

/* Edges that a point owns: 3 long ones towards +x, +y, +z; a centre also its 8 short ones. */
enum { SLOTS = 11, LONG_SLOTS = 3 };

/* A lattice point by doubled coordinates: corners are even, centres odd, in all three. */
typedef struct lattice {
    stuff_level level;
    const void *body;
    double origin[3], half; /* x = origin + half * doubled coordinate */
    int32_t cells[3];
    int64_t corner_count, point_count; /* corners first, then centres */
    double (*position)[3];             /* of points, warped ones moved */
    int8_t *sign;                      /* 1 inside, 0 on the surface, -1 outside */
    int32_t *node;                     /* of the solid, -1: none yet */
    int32_t *slot;                     /* SLOTS a point: the cut on that edge, or -1 */
    int32_t cut_count, cut_room;
    double (*cut)[3];
    int32_t *cut_node;
    solid *out;
    bool has_failed;
} lattice;

typedef struct site {
    int32_t c[3];
} site;

static int64_t index_of(const lattice *l, site p)
{
    const int32_t odd = p.c[0] & 1;
    int64_t index = 0;
    for (int k = 2; k >= 0; --k) {
        index = index * (l->cells[k] + 1 - odd) + (p.c[k] >> 1);
    }
    return odd != 0 ? l->corner_count + index : index;
}

static bool is_inside_lattice(const lattice *l, site p)
{
    for (int k = 0; k < 3; ++k) {
        if (p.c[k] < 0 || p.c[k] > 2 * l->cells[k]) {
            return false;
        }
    }
    return true;
}

/* The 14 neighbours: 0..5 along the axes, 6..13 diagonal. */
static site beside(site p, int direction)
{
    if (direction < 6) {
        p.c[direction / 2] += direction % 2 != 0 ? 2 : -2;
    } else {
        for (int k = 0; k < 3; ++k) {
            p.c[k] += (direction - 6) >> k & 1 ? 1 : -1;
        }
    }
    return p;
}

/* Where the cut of the edge from p to q is kept. */
static int32_t *slot_of(const lattice *l, site p, site q)
{
    int slot = 0;
    if (((p.c[0] ^ q.c[0]) & 1) == 0) {
        for (int k = 0; k < 3; ++k) {
            slot = p.c[k] != q.c[k] ? k : slot;
        }
        p = p.c[slot] < q.c[slot] ? p : q;
    } else {
        const site centre = (p.c[0] & 1) != 0 ? p : q;
        const site corner = (p.c[0] & 1) != 0 ? q : p;
        slot = LONG_SLOTS;
        for (int k = 0; k < 3; ++k) {
            slot += corner.c[k] > centre.c[k] ? 1 << k : 0;
        }
        p = centre;
    }
    return &l->slot[SLOTS * index_of(l, p) + slot];
}

static bool is_long(site p, site q)
{
    return ((p.c[0] ^ q.c[0]) & 1) == 0;
}

/* ---- memory ---- */

static void lattice_fini(lattice *l)
{
    SS_EACH(ss_memory_free, l->position, l->sign, l->node, l->slot, l->cut, l->cut_node);
}

static bool lattice_init(lattice *l, const double low[3], const double high[3], double edge)
{
    double cubes = 1.0;
    for (int k = 0; k < 3; ++k) {
        const double count = ceil((high[k] - low[k]) / edge) + 1.0;
        cubes *= count;
        if (!(cubes <= STUFF_MAX_CELLS)) {
            return false;
        }
        l->cells[k] = (int32_t)count;
        l->origin[k] = 0.5 * (low[k] + high[k] - count * edge);
    }
    l->half = 0.5 * edge;
    l->corner_count =
        ((int64_t)l->cells[0] + 1) * ((int64_t)l->cells[1] + 1) * ((int64_t)l->cells[2] + 1);
    l->point_count =
        l->corner_count + (int64_t)l->cells[0] * (int64_t)l->cells[1] * (int64_t)l->cells[2];
    const size_t count = (size_t)l->point_count;
    l->position = ss_memory_get(count, sizeof *l->position);
    l->sign = ss_memory_get(count, sizeof *l->sign);
    l->node = ss_memory_get(count, sizeof *l->node);
    l->slot = ss_memory_get(count * SLOTS, sizeof *l->slot);
    if (l->position == NULL || l->sign == NULL || l->node == NULL || l->slot == NULL) {
        return false;
    }
    memset(l->node, 0xff, count * sizeof *l->node);
    memset(l->slot, 0xff, count * SLOTS * sizeof *l->slot);
    return true;
}

/* Calls `visit` for every point, corners and centres of a layer after each other. */
static void each_point(lattice *l, void (*visit)(lattice *l, site p))
{
    site p;
    for (p.c[2] = 0; p.c[2] <= 2 * l->cells[2]; ++p.c[2]) {
        const int32_t odd = p.c[2] & 1;
        for (p.c[1] = odd; p.c[1] <= 2 * l->cells[1]; p.c[1] += 2) {
            for (p.c[0] = odd; p.c[0] <= 2 * l->cells[0]; p.c[0] += 2) {
                visit(l, p);
            }
        }
    }
}

/* ---- 2. signs and cuts ---- */

static void set_sign(lattice *l, site p)
{
    const int64_t i = index_of(l, p);
    for (int k = 0; k < 3; ++k) {
        l->position[i][k] = l->origin[k] + l->half * p.c[k];
    }
    const double f = l->level(l->body, l->position[i]);
    l->sign[i] = (int8_t)((f < 0.0) - (f > 0.0));
}

/* The surface between `inside` and `outside`, by bisection. */
static void find_cut(const lattice *l, const double inside[3], const double outside[3],
                     double out[3])
{
    double low = 0.0;
    double high = 1.0;
    double along[3];
    ss_sub3(along, outside, inside);
    for (int i = 0; i < 44; ++i) {
        const double middle = 0.5 * (low + high);
        ss_madd3(out, inside, middle, along);
        if (l->level(l->body, out) < 0.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
}

static bool add_cut(lattice *l, const double x[3], int32_t *out)
{
    double(*all)[3] = ss_memory_grow(l->cut, l->cut_count, &l->cut_room, sizeof *l->cut);
    if (all == NULL) {
        return false;
    }
    l->cut = all;
    ss_copy3(l->cut[l->cut_count], x);
    *out = l->cut_count++;
    return true;
}

static void set_cuts(lattice *l, site p)
{
    const int64_t i = index_of(l, p);
    for (int direction = 0; direction < 14; ++direction) {
        const site q = beside(p, direction);
        if (l->sign[i] <= 0 || !is_inside_lattice(l, q) || l->sign[index_of(l, q)] >= 0) {
            continue;
        }
        double x[3];
        find_cut(l, l->position[i], l->position[index_of(l, q)], x);
        l->has_failed = !add_cut(l, x, slot_of(l, p, q)) || l->has_failed;
    }
}

/* ---- 3. warping ---- */

static void warp(lattice *l, site p)
{
    const int64_t i = index_of(l, p);
    int32_t nearest = -1;
    double least = 1.0; /* of the distance allowed */
    for (int direction = 0; direction < 14 && l->sign[i] != 0; ++direction) {
        const site q = beside(p, direction);
        const int32_t cut = is_inside_lattice(l, q) ? *slot_of(l, p, q) : -1;
        if (cut >= 0) {
            double d[3];
            ss_sub3(d, l->cut[cut], l->position[i]);
            const double allowed = is_long(p, q) ? 2.0 * alpha_long : 1.7320508 * alpha_short;
            const double share = ss_norm3(d) / (allowed * l->half);
            nearest = share < least ? cut : nearest;
            least = fmin(least, share);
        }
    }
    if (nearest < 0) {
        return;
    }
    ss_copy3(l->position[i], l->cut[nearest]);
    l->sign[i] = 0;
    for (int direction = 0; direction < 14; ++direction) {
        const site q = beside(p, direction);
        if (is_inside_lattice(l, q)) {
            *slot_of(l, p, q) = -1;
        }
    }
}

/* ---- 4. tetrahedra ---- */

static int32_t site_node(lattice *l, site p)
{
    const int64_t i = index_of(l, p);
    if (l->node[i] < 0) {
        l->has_failed = !solid_add_node(l->out, l->position[i], &l->node[i]) || l->has_failed;
        l->out->surface_count += l->sign[i] == 0;
    }
    return l->node[i];
}

static int32_t cut_node(lattice *l, site inside, site outside)
{
    const int32_t cut = *slot_of(l, inside, outside);
    if (l->cut_node[cut] < 0) {
        l->has_failed = !solid_add_node(l->out, l->cut[cut], &l->cut_node[cut]) || l->has_failed;
        ++l->out->surface_count;
    }
    return l->cut_node[cut];
}

static void add(lattice *l, int32_t a, int32_t b, int32_t c, int32_t d)
{
    l->has_failed = l->has_failed || !solid_add_tetrahedron(l->out, a, b, c, d);
}

/* On the face of inner points p, q and outer point m: does the diagonal end at p (and at the cut
 * of q m), not at q? */
static bool is_diagonal_at(site p, site q, site m)
{
    if (is_long(p, m)) {
        return false; /* it ends at the cut of p m, that is at q */
    }
    if (is_long(q, m)) {
        return true;
    }
    int32_t sum[2] = {0, 0};
    for (int k = 0; k < 3; ++k) {
        sum[0] += p.c[k] >> 1;
        sum[1] += q.c[k] >> 1;
    }
    return (sum[0] & 1) == 0;
}

/* A prism with the columns low[k], high[k]. before[k]: 1 when the diagonal between the columns k
 * and (k + 1) % 3 joins high[k] and low[k + 1], 0 when low[k] and high[k + 1], -1 when free. */
static void add_prism(lattice *l, const int32_t low[3], const int32_t high[3], const int before[3])
{
    static const int8_t orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                        {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    int best = -1;
    double least = 3.0;
    for (int o = 0; o < 6 && !l->has_failed; ++o) {
        int rank[3];
        bool agrees = true;
        for (int k = 0; k < 3; ++k) {
            rank[orders[o][k]] = k;
        }
        for (int k = 0; k < 3; ++k) {
            agrees = agrees && (before[k] < 0 || before[k] == (rank[k] < rank[(k + 1) % 3]));
        }
        double worst = 0.0;
        int32_t at[3] = {low[0], low[1], low[2]};
        for (int k = 0; k < 3 && agrees; ++k) {
            const int c = orders[o][k];
            double(*x)[3] = l->out->position;
            const double badness =
                fmin(solid_badness(x[at[0]], x[at[1]], x[at[2]], x[high[c]], 0.0),
                     solid_badness(x[at[0]], x[at[2]], x[at[1]], x[high[c]], 0.0));
            worst = fmax(worst, badness);
            at[c] = high[c];
        }
        if (agrees && worst < least) {
            least = worst;
            best = o;
        }
    }
    int32_t at[3] = {low[0], low[1], low[2]};
    for (int k = 0; k < 3 && best >= 0; ++k) {
        const int c = orders[best][k];
        add(l, at[0], at[1], at[2], high[c]);
        at[c] = high[c];
    }
}

/* Points sorted by sign: inner ones first, outer ones last. */
static void cut_tetrahedron(lattice *l, const site p[4], int inner, int outer)
{
    if (outer == 0) {
        add(l, site_node(l, p[0]), site_node(l, p[1]), site_node(l, p[2]), site_node(l, p[3]));
    } else if (inner == 1) {
        int32_t node[4];
        for (int k = 0; k < 4; ++k) {
            node[k] = k < 4 - outer ? site_node(l, p[k]) : cut_node(l, p[0], p[k]);
        }
        add(l, node[0], node[1], node[2], node[3]);
    } else if (inner == 2 && outer == 1) {
        const int32_t a = site_node(l, p[0]);
        const int32_t b = site_node(l, p[1]);
        const int32_t apex = site_node(l, p[2]);
        const int32_t cut_a = cut_node(l, p[0], p[3]);
        const int32_t cut_b = cut_node(l, p[1], p[3]);
        const bool is_at_a = is_diagonal_at(p[0], p[1], p[3]);
        add(l, a, b, is_at_a ? cut_b : cut_a, apex);
        add(l, is_at_a ? a : b, cut_a, cut_b, apex);
    } else if (inner == 3) {
        int32_t low[3], high[3];
        int before[3];
        for (int k = 0; k < 3; ++k) {
            low[k] = site_node(l, p[k]);
            high[k] = cut_node(l, p[k], p[3]);
            before[k] = !is_diagonal_at(p[k], p[(k + 1) % 3], p[3]);
        }
        add_prism(l, low, high, before);
    } else {
        const int32_t low[3] = {site_node(l, p[0]), cut_node(l, p[0], p[2]),
                                cut_node(l, p[0], p[3])};
        const int32_t high[3] = {site_node(l, p[1]), cut_node(l, p[1], p[2]),
                                 cut_node(l, p[1], p[3])};
        const int before[3] = {!is_diagonal_at(p[0], p[1], p[2]), -1,
                               is_diagonal_at(p[0], p[1], p[3])};
        add_prism(l, low, high, before);
    }
}

static void take_tetrahedron(lattice *l, site a, site b, site c, site d)
{
    const site given[4] = {a, b, c, d};
    site sorted[4];
    int count = 0;
    int inner = 0;
    int outer = 0;
    for (int sign = 1; sign >= -1; --sign) {
        for (int k = 0; k < 4; ++k) {
            if (l->sign[index_of(l, given[k])] == sign) {
                sorted[count++] = given[k];
                inner += sign > 0;
                outer += sign < 0;
            }
        }
    }
    if (inner > 0 && !l->has_failed) {
        cut_tetrahedron(l, sorted, inner, outer);
    }
}

/* The tetrahedra around the long edges from centre p towards +x, +y, +z. */
static void take_centre(lattice *l, site p)
{
    for (int axis = 0; axis < 3 && (p.c[0] & 1) != 0; ++axis) {
        site q = p;
        q.c[axis] += 2;
        if (!is_inside_lattice(l, q)) {
            continue;
        }
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        site ring[4];
        for (int k = 0; k < 4; ++k) {
            ring[k] = p;
            ring[k].c[axis] += 1;
            ring[k].c[u] += k == 0 || k == 3 ? -1 : 1;
            ring[k].c[v] += k < 2 ? -1 : 1;
        }
        for (int k = 0; k < 4; ++k) {
            take_tetrahedron(l, p, q, ring[k], ring[(k + 1) % 4]);
        }
    }
}

bool stuff(stuff_level level, const void *body, const double low[3], const double high[3],
           double edge, solid *out)
{
    lattice l = {.level = level, .body = body, .out = out};
    *out = (solid){0};
    bool is_done = lattice_init(&l, low, high, edge);
    if (is_done) {
        each_point(&l, set_sign);
        each_point(&l, set_cuts);
        l.cut_node = ss_memory_get((size_t)l.cut_count, sizeof *l.cut_node);
        is_done = l.cut_node != NULL && !l.has_failed;
    }
    if (is_done) {
        memset(l.cut_node, 0xff, (size_t)l.cut_count * sizeof *l.cut_node);
        each_point(&l, warp);
        each_point(&l, take_centre);
        is_done = !l.has_failed;
    }
    lattice_fini(&l);
    if (!is_done) {
        solid_fini(out);
    }
    return is_done;
}
