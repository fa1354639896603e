/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * 1. Fibonacci lattice (v, u) = ((k + 1/2) / n, frac(k / golden ratio)) on the unit square, taken
 *    to the sphere by the inverse of the organ's cumulative area over (z, phi): even in area on
 *    the organ, whatever its shape, so that no point has far to go.
 * 2. Delaunay triangulation of the directions on the unit sphere: points are inserted one by one,
 *    edges flipped while the point opposite lies inside the circle (Lawson).
 * 3. Relaxation on the organ: each point moves to the area-weighted centroid of its triangles,
 *    back onto the surface; edges whose two opposite angles sum to more than pi are flipped.
 * 4. Renumbering along a Hilbert curve.
 *
 * Subdividing an icosahedron was rejected: only n = 10 f^2 + 2 exist, and stretched over a kidney
 * its triangles are stretched too.
 */
#include "spread.h"

#include "mesh/mesh.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

#include <stdlib.h>
#include <string.h>

enum { AREA_ROWS = 128, AREA_COLUMNS = 192, RELAXATIONS = 240, HINT_ROWS = 32, HINT_COLUMNS = 64 };

typedef struct net {
    int32_t node_count, triangle_count;
    double (*x)[3]; /* directions, then positions */
    int32_t (*triangle)[3];
    int32_t (*beside)[3];                  /* the triangle across the edge opposite corner c */
    int32_t hint[HINT_ROWS][HINT_COLUMNS]; /* a triangle near that direction */
    int32_t *stack;                        /* of triangles whose edges to test */
} net;

/* ---- 1. even directions ---- */

typedef struct area_map {
    double row[AREA_ROWS + 1];                  /* cumulative, 0..1 */
    double column[AREA_ROWS][AREA_COLUMNS + 1]; /* cumulative in each row, 0..1 */
} area_map;

static void direction(double z, double phi, double out[3])
{
    /* The sphere's axis is the organ's x, the long one. */
    const double r = sqrt(fmax(0.0, 1.0 - z * z));
    ss_set3(out, z, r * cos(phi), r * sin(phi));
}

static void place(const organ *o, int row, int column, double out[3])
{
    double d[3];
    direction(-1.0 + 2.0 * row / AREA_ROWS, 2.0 * SS_PI * column / AREA_COLUMNS, d);
    organ_place(o, d, out);
}

static double triangle_area(const double a[3], const double b[3], const double c[3])
{
    double normal[3];
    ss_normal3(normal, a, b, c);
    return 0.5 * ss_norm3(normal);
}

static void measure(const organ *o, area_map *map)
{
    static double low[AREA_COLUMNS + 1][3];
    static double high[AREA_COLUMNS + 1][3];
    for (int c = 0; c <= AREA_COLUMNS; ++c) {
        place(o, 0, c, high[c]);
    }
    map->row[0] = 0.0;
    for (int r = 0; r < AREA_ROWS; ++r) {
        double *sum = map->column[r];
        memcpy(low, high, sizeof low);
        for (int c = 0; c <= AREA_COLUMNS; ++c) {
            place(o, r + 1, c, high[c]);
        }
        sum[0] = 0.0;
        for (int c = 0; c < AREA_COLUMNS; ++c) {
            sum[c + 1] = sum[c] + triangle_area(low[c], low[c + 1], high[c]) +
                         triangle_area(high[c], low[c + 1], high[c + 1]);
        }
        map->row[r + 1] = map->row[r] + sum[AREA_COLUMNS];
        for (int c = 0; c < AREA_COLUMNS; ++c) {
            sum[c] /= sum[AREA_COLUMNS];
        }
        sum[AREA_COLUMNS] = 1.0;
    }
    for (int r = 0; r < AREA_ROWS; ++r) {
        map->row[r] /= map->row[AREA_ROWS];
    }
    map->row[AREA_ROWS] = 1.0;
}

/* Where in `sum` (count + 1 increasing values from 0 to 1) `value` lies: 0..1, and its cell. */
static double invert(const double *sum, int count, double value, int *out_cell)
{
    int low = 0;
    int high = count;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (sum[middle] <= value) {
            low = middle;
        } else {
            high = middle;
        }
    }
    *out_cell = low;
    return (low + (value - sum[low]) / (sum[low + 1] - sum[low])) / count;
}

static void spread_directions(net *t, const area_map *map)
{
    const double golden = 0.61803398874989484820;
    for (int32_t k = 0; k < t->node_count; ++k) {
        int row = 0;
        int column = 0;
        const double z = invert(map->row, AREA_ROWS, (k + 0.5) / t->node_count, &row);
        const double u = fmod(k * golden, 1.0);
        direction(2.0 * z - 1.0, 2.0 * SS_PI * invert(map->column[row], AREA_COLUMNS, u, &column),
                  t->x[k]);
    }
}

/* ---- 2. triangulation ---- */

static double determinant(const double a[3], const double b[3], const double c[3])
{
    double bc[3];
    ss_cross3(bc, b, c);
    return ss_dot3(a, bc);
}

static int corner_towards(const net *t, int32_t triangle, int32_t neighbour)
{
    const int32_t *beside = t->beside[triangle];
    return beside[0] == neighbour ? 0 : beside[1] == neighbour ? 1 : 2;
}

static void put(net *t, int32_t number, const int32_t node[3], const int32_t beside[3])
{
    memcpy(t->triangle[number], node, sizeof t->triangle[number]);
    memcpy(t->beside[number], beside, sizeof t->beside[number]);
}

static void replace_neighbour(net *t, int32_t triangle, int32_t old, int32_t new)
{
    t->beside[triangle][corner_towards(t, triangle, old)] = new;
}

/* Triangles p = (a, b, c) and q = (d, c, b) become (a, b, d) and (d, c, a); c: corner of p. */
static void flip(net *t, int32_t p, int corner)
{
    const int32_t q = t->beside[p][corner];
    const int far = corner_towards(t, q, p);
    const int32_t a = t->triangle[p][corner];
    const int32_t b = t->triangle[p][(corner + 1) % 3];
    const int32_t c = t->triangle[p][(corner + 2) % 3];
    const int32_t d = t->triangle[q][far];
    const int32_t beside_ca = t->beside[p][(corner + 1) % 3];
    const int32_t beside_ab = t->beside[p][(corner + 2) % 3];
    const int32_t beside_bd = t->beside[q][(far + 1) % 3];
    const int32_t beside_dc = t->beside[q][(far + 2) % 3];
    put(t, p, (int32_t[3]){a, b, d}, (int32_t[3]){beside_bd, q, beside_ab});
    put(t, q, (int32_t[3]){d, c, a}, (int32_t[3]){beside_ca, p, beside_dc});
    replace_neighbour(t, beside_bd, q, p);
    replace_neighbour(t, beside_ca, p, q);
}

static int32_t *hint_of(net *t, const double x[3])
{
    const double phi = atan2(x[2], x[1]) / (2.0 * SS_PI) + 0.5;
    int row = (int)(0.5 * (x[0] + 1.0) * HINT_ROWS);
    int column = (int)(phi * HINT_COLUMNS);
    row = row < HINT_ROWS ? row : HINT_ROWS - 1;
    column = column < HINT_COLUMNS ? column : HINT_COLUMNS - 1;
    return &t->hint[row][column];
}

/* The triangle under x: walks towards it over edges that have it on their far side. */
static int32_t locate(net *t, const double x[3])
{
    int32_t at = *hint_of(t, x);
    for (int32_t steps = 0; steps < t->triangle_count; ++steps) {
        int32_t next = -1;
        for (int c = 0; c < 3 && next < 0; ++c) {
            const int32_t *node = t->triangle[at];
            if (determinant(t->x[node[(c + 1) % 3]], t->x[node[(c + 2) % 3]], x) < 0.0) {
                next = t->beside[at][c];
            }
        }
        if (next < 0) {
            return at;
        }
        at = next;
    }
    return at;
}

/* Is the point opposite edge `corner` of triangle p inside p's circle: above p's plane? */
static bool circle_holds_opposite(const net *t, int32_t p, int corner)
{
    const int32_t *node = t->triangle[p];
    const int32_t q = t->beside[p][corner];
    double ab[3], ac[3], ad[3];
    ss_sub3(ab, t->x[node[1]], t->x[node[0]]);
    ss_sub3(ac, t->x[node[2]], t->x[node[0]]);
    ss_sub3(ad, t->x[t->triangle[q][corner_towards(t, q, p)]], t->x[node[0]]);
    return determinant(ad, ab, ac) > 1e-14;
}

/* Splits the triangle under node n in three and restores the Delaunay property around it. */
static void insert(net *t, int32_t n)
{
    const int32_t p = locate(t, t->x[n]);
    const int32_t q = t->triangle_count;
    const int32_t r = q + 1;
    const int32_t a = t->triangle[p][0];
    const int32_t b = t->triangle[p][1];
    const int32_t c = t->triangle[p][2];
    const int32_t across_a = t->beside[p][0];
    const int32_t across_b = t->beside[p][1];
    const int32_t across_c = t->beside[p][2];
    t->triangle_count += 2;
    put(t, p, (int32_t[3]){n, b, c}, (int32_t[3]){across_a, q, r});
    put(t, q, (int32_t[3]){n, c, a}, (int32_t[3]){across_b, r, p});
    put(t, r, (int32_t[3]){n, a, b}, (int32_t[3]){across_c, p, q});
    replace_neighbour(t, across_b, p, q);
    replace_neighbour(t, across_c, p, r);

    /* New edges all end in n: only those opposite it can be wrong. */
    int32_t depth = 0;
    t->stack[depth++] = p;
    t->stack[depth++] = q;
    t->stack[depth++] = r;
    while (depth > 0) {
        const int32_t triangle = t->stack[--depth];
        const int corner = t->triangle[triangle][0] == n   ? 0
                           : t->triangle[triangle][1] == n ? 1
                                                           : 2;
        if (circle_holds_opposite(t, triangle, corner)) {
            const int32_t other = t->beside[triangle][corner];
            flip(t, triangle, corner);
            t->stack[depth++] = triangle;
            t->stack[depth++] = other;
        }
    }
    *hint_of(t, t->x[n]) = p;
}

/* The four nodes nearest to the corners of a regular tetrahedron. */
static void start_triangles(net *t, int32_t start[4])
{
    static const double corner[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    for (int c = 0; c < 4; ++c) {
        start[c] = 0;
        for (int32_t i = 1; i < t->node_count; ++i) {
            if (ss_dot3(corner[c], t->x[i]) > ss_dot3(corner[c], t->x[start[c]])) {
                start[c] = i;
            }
        }
    }
    static const int face[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
    for (int f = 0; f < 4; ++f) {
        const double *const x[3] = {t->x[start[face[f][0]]], t->x[start[face[f][1]]],
                                    t->x[start[face[f][2]]]};
        const bool is_outward = determinant(x[0], x[1], x[2]) > 0.0;
        for (int c = 0; c < 3; ++c) {
            const int corner_index = is_outward ? face[f][c] : face[f][2 - c];
            t->triangle[f][c] = start[corner_index];
            t->beside[f][c] = corner_index; /* face k lies opposite corner k */
        }
    }
    t->triangle_count = 4;
}

static void triangulate(net *t)
{
    int32_t start[4];
    start_triangles(t, start);
    uint32_t bits = 1;
    while ((1u << bits) < (uint32_t)t->node_count) {
        ++bits;
    }
    /* In bit-reversed order, so that the points spread over the sphere from the start. */
    for (uint32_t i = 0; i < 1u << bits; ++i) {
        uint32_t reversed = 0;
        for (uint32_t b = 0; b < bits; ++b) {
            reversed |= (i >> b & 1u) << (bits - 1 - b);
        }
        const int32_t n = (int32_t)reversed;
        if (n < t->node_count && n != start[0] && n != start[1] && n != start[2] && n != start[3]) {
            insert(t, n);
        }
    }
}

/* ---- 3. relaxation ---- */

/* Do three or fewer triangles meet at corner c of triangle p? Flipping there would fold. */
static bool is_lonely(const net *t, int32_t p, int corner)
{
    const int32_t node = t->triangle[p][corner];
    int32_t at = p;
    int count = 0;
    do {
        const int c = t->triangle[at][0] == node ? 0 : t->triangle[at][1] == node ? 1 : 2;
        at = t->beside[at][(c + 1) % 3];
        ++count;
    } while (at != p && count < 5);
    return count <= 3;
}

/* Angle at x between the directions to a and b. */
static double angle(const double x[3], const double a[3], const double b[3])
{
    double u[3], v[3], uv[3];
    ss_sub3(u, a, x);
    ss_sub3(v, b, x);
    ss_cross3(uv, u, v);
    return atan2(ss_norm3(uv), ss_dot3(u, v));
}

static bool should_flip(const net *t, int32_t p, int corner)
{
    const int32_t q = t->beside[p][corner];
    const int far = corner_towards(t, q, p);
    const double *a = t->x[t->triangle[p][corner]];
    const double *b = t->x[t->triangle[p][(corner + 1) % 3]];
    const double *c = t->x[t->triangle[p][(corner + 2) % 3]];
    const double *d = t->x[t->triangle[q][far]];
    return angle(a, b, c) + angle(d, b, c) > SS_PI + 1e-9 && !is_lonely(t, p, (corner + 1) % 3) &&
           !is_lonely(t, p, (corner + 2) % 3);
}

static int32_t flip_edges(net *t)
{
    int32_t flips = 0;
    for (int32_t p = 0; p < t->triangle_count; ++p) {
        for (int c = 0; c < 3; ++c) {
            if (p < t->beside[p][c] && should_flip(t, p, c)) {
                flip(t, p, c);
                ++flips;
            }
        }
    }
    return flips;
}

/* Of one node's triangles: sums of area times centroid, of area, and of area vectors. */
typedef struct ring {
    double moment[3], area, normal[3];
} ring;

static void sum_rings(const net *t, ring *rings)
{
    memset(rings, 0, (size_t)t->node_count * sizeof *rings);
    for (int32_t p = 0; p < t->triangle_count; ++p) {
        const int32_t *node = t->triangle[p];
        const double *a = t->x[node[0]];
        const double *b = t->x[node[1]];
        const double *c = t->x[node[2]];
        double normal[3];
        ss_normal3(normal, a, b, c);
        const double area = ss_norm3(normal);
        for (int corner = 0; corner < 3; ++corner) {
            ring *r = &rings[node[corner]];
            ss_madd3(r->moment, r->moment, area / 3.0, a);
            ss_madd3(r->moment, r->moment, area / 3.0, b);
            ss_madd3(r->moment, r->moment, area / 3.0, c);
            ss_add3(r->normal, r->normal, normal);
            r->area += area;
        }
    }
}

/* Along the surface only, then back onto it: straight to the centroid, points at a thin tip would
 * go inside and come out anywhere. */
static void move_nodes(net *t, const organ *o, ring *rings)
{
    sum_rings(t, rings);
    for (int32_t i = 0; i < t->node_count; ++i) {
        ring *r = &rings[i];
        if (r->area > 0.0) {
            double step[3];
            ss_scale3(step, r->moment, 1.0 / r->area);
            ss_sub3(step, step, t->x[i]);
            ss_normalize3(r->normal);
            ss_madd3(step, step, -ss_dot3(step, r->normal), r->normal);
            ss_add3(t->x[i], t->x[i], step);
        }
        organ_project(o, t->x[i], 1);
    }
}

static bool relax(net *t, const organ *o)
{
    ring *rings = ss_memory_get((size_t)t->node_count, sizeof *rings);
    if (rings == NULL) {
        return false;
    }
    for (int32_t i = 0; i < t->node_count; ++i) {
        double d[3];
        ss_copy3(d, t->x[i]);
        organ_place(o, d, t->x[i]);
    }
    for (int i = 0; i < RELAXATIONS; ++i) {
        (void)flip_edges(t);
        move_nodes(t, o, rings);
    }
    for (int32_t i = 0; i < t->node_count; ++i) {
        organ_project(o, t->x[i], 5);
    }
    for (int i = 0; i < 32 && flip_edges(t) > 0; ++i) {
    }
    ss_memory_free(rings);
    return true;
}

/* ---- 4. numbering ---- */

static int compare_triangles(const void *left, const void *right)
{
    return ss_order_ints(left, right, 3);
}

static bool number_nodes(const net *t, spread *s)
{
    int32_t *order = ss_memory_get((size_t)t->node_count, sizeof *order);
    int32_t *new_number = ss_memory_get((size_t)t->node_count, sizeof *new_number);
    double low[3], high[3];
    ss_bounds3(t->node_count, (const double(*)[3])t->x, low, high);
    const double size = fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    const bool is_done = order != NULL && new_number != NULL &&
                         ss_mesh_curve_order(t->node_count, (const double(*)[3])t->x, size, order);
    if (is_done) {
        for (int32_t i = 0; i < t->node_count; ++i) {
            new_number[order[i]] = i;
            ss_copy3(s->position[i], t->x[order[i]]);
        }
        /* Each triangle starts at its lowest node; triangles in the order of their nodes. */
        for (int32_t p = 0; p < t->triangle_count; ++p) {
            const int32_t *node = t->triangle[p];
            const int32_t n[3] = {new_number[node[0]], new_number[node[1]], new_number[node[2]]};
            const int c = n[0] < n[1] ? (n[0] < n[2] ? 0 : 2) : (n[1] < n[2] ? 1 : 2);
            for (int k = 0; k < 3; ++k) {
                s->triangle[p][k] = n[(c + k) % 3];
            }
        }
        qsort(s->triangle, (size_t)t->triangle_count, sizeof *s->triangle, compare_triangles);
    }
    SS_EACH(ss_memory_free, order, new_number);
    return is_done;
}

/* ---- all of it ---- */

static bool net_init(net *t, int32_t count)
{
    t->node_count = count;
    t->x = ss_memory_get((size_t)count, sizeof *t->x);
    t->triangle = ss_memory_get(2 * (size_t)count, sizeof *t->triangle);
    t->beside = ss_memory_get(2 * (size_t)count, sizeof *t->beside);
    t->stack = ss_memory_get(8 * (size_t)count, sizeof *t->stack);
    return t->x != NULL && t->triangle != NULL && t->beside != NULL && t->stack != NULL;
}

static void net_fini(net *t)
{
    SS_EACH(ss_memory_free, t->x, t->triangle, t->beside, t->stack);
}

bool spread_init(spread *s, const organ *o, int32_t point_count)
{
    *s = (spread){.node_count = point_count, .triangle_count = 2 * point_count - 4};
    s->position = ss_memory_get((size_t)point_count, sizeof *s->position);
    s->triangle = ss_memory_get((size_t)s->triangle_count, sizeof *s->triangle);
    net *t = ss_memory_get(1, sizeof *t);
    area_map *map = ss_memory_get(1, sizeof *map);
    bool is_done = s->position != NULL && s->triangle != NULL && t != NULL && map != NULL &&
                   net_init(t, point_count);
    if (is_done) {
        measure(o, map);
        spread_directions(t, map);
        triangulate(t);
        is_done = relax(t, o) && number_nodes(t, s);
    }
    if (t != NULL) {
        net_fini(t);
    }
    ss_memory_free(t);
    ss_memory_free(map);
    if (!is_done) {
        spread_fini(s);
    }
    return is_done;
}

void spread_fini(spread *s)
{
    ss_memory_free(s->position);
    ss_memory_free(s->triangle);
    *s = (spread){0};
}
