/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Smoothing by search (Freitag and Ollivier-Gooch 1997 in purpose: the worst element counts, not
 * the mean): a node whose worst tetrahedron is bad tries the centroid of its neighbours and six
 * steps along the axes, and takes the best place if that lowers the greatest |cos| of a dihedral
 * angle around it. No step makes the worst worse, so a bound on the angles that held before holds
 * after. Optimising a smooth mean was rejected: it buys good elements with bad ones.
 *
 * Coarsening by collapse: the tetrahedra around an inner node i fill a ball. Put in its place a
 * neighbour j: those that had both vanish, and the others, with i replaced by j, fill the same ball
 * exactly if all their volumes are positive. Of the neighbours the one with the best angles is
 * taken, if none is below 22 degrees. A sweep touches no star twice.
 */
#include "solid.h"

#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

#include <stdlib.h>
#include <string.h>

/* Tetrahedra between 35 and 145 degrees are left alone. */
static const double good_enough = 0.81915;
/* Of the edge; a lower tetrahedron is too small, for an explicit step goes with the least height.
 * At 0.3 the least of an organ is 0.53 of the median and the worst angle 35 degrees, at 0.4 0.71
 * and 33.7, at 0.5 no step is longer and the worst angle is 30. */
static const double least_height = 0.4;

void solid_fini(solid *s)
{
    ss_memory_free(s->position);
    ss_memory_free(s->tetrahedron);
    *s = (solid){0};
}

bool solid_add_node(solid *s, const double x[3], int32_t *out_node)
{
    double(*all)[3] =
        ss_memory_grow(s->position, s->node_count, &s->node_room, sizeof *s->position);
    if (all != NULL) {
        s->position = all;
        *out_node = s->node_count++;
        ss_copy3(s->position[*out_node], x);
    }
    return all != NULL;
}

bool solid_add_tetrahedron(solid *s, int32_t a, int32_t b, int32_t c, int32_t d)
{
    int32_t(*all)[4] = ss_memory_grow(s->tetrahedron, s->tetrahedron_count, &s->tetrahedron_room,
                                      sizeof *s->tetrahedron);
    if (all != NULL) {
        s->tetrahedron = all;
        const bool is_turned =
            ss_six_volumes3(s->position[a], s->position[b], s->position[c], s->position[d]) < 0.0;
        const int32_t node[4] = {a, b, is_turned ? d : c, is_turned ? c : d};
        memcpy(s->tetrahedron[s->tetrahedron_count++], node, sizeof node);
    }
    return all != NULL;
}

double solid_badness(const double a[3], const double b[3], const double c[3], const double d[3],
                     double height)
{
    const double volumes = ss_six_volumes3(a, b, c, d);
    if (!(volumes > 0.0)) {
        return 2.0;
    }
    double area = 0.0;
    const double *const corner[4] = {a, b, c, d};
    double normal[4][3];
    for (int f = 0; f < 4; ++f) {
        const double *origin = corner[(f + 1) % 4];
        ss_normal3(normal[f], origin, corner[(f + 2) % 4], corner[(f + 3) % 4]);
        const double size = ss_normalize3(normal[f]);
        area = size > area ? size : area;
    }
    double worst = height > 0.0 ? 1.0 - (1.0 - good_enough) * volumes / (area * height) : 0.0;
    for (int f = 0; f < 4; ++f) {
        for (int g = 0; g < f; ++g) {
            const double cosine = fabs(ss_dot3(normal[f], normal[g]));
            worst = cosine > worst ? cosine : worst;
        }
    }
    return worst;
}

/* ---- smoothing ---- */

typedef struct star_table {
    int32_t *start; /* node_count + 1 */
    int32_t *tetrahedron;
    bool *is_surface;
} star_table;

static void star_table_fini(star_table *t)
{
    SS_EACH(ss_memory_free, t->start, t->tetrahedron, t->is_surface);
}

static bool star_table_init(star_table *t, const solid *s)
{
    const size_t nodes = (size_t)s->node_count;
    *t = (star_table){.start = ss_memory_get(nodes + 2, sizeof *t->start),
                      .tetrahedron =
                          ss_memory_get(4 * (size_t)s->tetrahedron_count, sizeof *t->tetrahedron),
                      .is_surface = ss_memory_get(nodes, sizeof *t->is_surface)};
    if (t->start == NULL || t->tetrahedron == NULL || t->is_surface == NULL) {
        star_table_fini(t);
        return false;
    }
    for (int32_t e = 0; e < s->tetrahedron_count; ++e) {
        for (int k = 0; k < 4; ++k) {
            ++t->start[s->tetrahedron[e][k] + 2];
        }
    }
    for (int32_t i = 0; i < s->node_count; ++i) {
        t->start[i + 2] += t->start[i + 1];
    }
    for (int32_t e = 0; e < s->tetrahedron_count; ++e) {
        for (int k = 0; k < 4; ++k) {
            t->tetrahedron[t->start[s->tetrahedron[e][k] + 1]++] = e;
        }
    }
    return true;
}

/* Has another tetrahedron around `node` the face of e opposite corner `k`? */
static bool has_neighbour(const solid *s, const star_table *t, int32_t e, int k)
{
    const int32_t *own = s->tetrahedron[e];
    const int32_t node = own[(k + 1) % 4];
    for (int32_t i = t->start[node]; i < t->start[node + 1]; ++i) {
        const int32_t *other = s->tetrahedron[t->tetrahedron[i]];
        int shared = 0;
        for (int c = 0; c < 12; ++c) {
            shared += other[c % 4] == own[(k + 1 + c / 4) % 4];
        }
        if (t->tetrahedron[i] != e && shared == 3) {
            return true;
        }
    }
    return false;
}

static void find_surface(const solid *s, star_table *t)
{
    for (int32_t e = 0; e < s->tetrahedron_count; ++e) {
        for (int k = 0; k < 4; ++k) {
            if (!has_neighbour(s, t, e, k)) {
                for (int c = 1; c < 4; ++c) {
                    t->is_surface[s->tetrahedron[e][(k + c) % 4]] = true;
                }
            }
        }
    }
}

static double star_badness(const solid *s, const star_table *t, int32_t node, double height,
                           double limit)
{
    double worst = 0.0;
    for (int32_t i = t->start[node]; i < t->start[node + 1] && worst < limit; ++i) {
        const int32_t *n = s->tetrahedron[t->tetrahedron[i]];
        worst = fmax(worst, solid_badness(s->position[n[0]], s->position[n[1]], s->position[n[2]],
                                          s->position[n[3]], height));
    }
    return worst;
}

static void star_centroid(const solid *s, const star_table *t, int32_t node, double out[3])
{
    double count = 0.0;
    ss_set3(out, 0.0, 0.0, 0.0);
    for (int32_t i = t->start[node]; i < t->start[node + 1]; ++i) {
        for (int k = 0; k < 4; ++k) {
            const int32_t other = s->tetrahedron[t->tetrahedron[i]][k];
            /* Of a surface node the neighbours on the surface: it is to stay there. */
            if (other != node && (!t->is_surface[node] || t->is_surface[other])) {
                ss_add3(out, out, s->position[other]);
                count += 1.0;
            }
        }
    }
    ss_scale3(out, out, 1.0 / count);
}

static void improve(solid *s, const star_table *t, int32_t node, double edge, double step,
                    void (*project)(const void *body, double x[3]), const void *body)
{
    double *x = s->position[node];
    double best = star_badness(s, t, node, least_height * edge, 3.0);
    if (best <= good_enough) {
        return;
    }
    double place[3], centroid[3];
    ss_copy3(place, x);
    star_centroid(s, t, node, centroid);
    const double start[3] = {x[0], x[1], x[2]};
    for (int trial = 0; trial < 7; ++trial) {
        if (trial == 0) {
            ss_copy3(x, centroid);
        } else {
            ss_copy3(x, start);
            x[(trial - 1) / 2] += trial % 2 != 0 ? step : -step;
        }
        if (t->is_surface[node]) {
            project(body, x);
        }
        const double badness = star_badness(s, t, node, least_height * edge, best);
        if (badness < best) {
            best = badness;
            ss_copy3(place, x);
        }
    }
    ss_copy3(x, place);
}

bool solid_smooth(solid *s, double edge, int sweeps, void (*project)(const void *body, double x[3]),
                  const void *body)
{
    star_table t;
    if (!star_table_init(&t, s)) {
        return false;
    }
    find_surface(s, &t);
    double step = 0.15 * edge;
    for (int sweep = 0; sweep < sweeps; ++sweep, step *= 0.85) {
        for (int32_t i = 0; i < s->node_count; ++i) {
            if (t.start[i + 1] > t.start[i] && (project != NULL || !t.is_surface[i])) {
                improve(s, &t, i, edge, step, project, body);
            }
        }
    }
    star_table_fini(&t);
    return true;
}

/* ---- coarsening ---- */

static const double collapse_limit = 0.92718; /* cos 22 degrees */

/* The worst of the tetrahedra around i with j in its place; above `limit` when it cannot be. */
static double collapse_badness(const solid *s, const star_table *t, int32_t i, int32_t j,
                               double longest, double limit)
{
    double worst = 0.0;
    for (int32_t n = t->start[i]; n < t->start[i + 1] && worst <= limit; ++n) {
        int32_t node[4];
        bool has_both = false;
        memcpy(node, s->tetrahedron[t->tetrahedron[n]], sizeof node);
        for (int k = 0; k < 4; ++k) {
            double d[3];
            ss_sub3(d, s->position[node[k]], s->position[j]);
            worst = node[k] != i && ss_norm3(d) > longest ? 3.0 : worst;
            has_both = has_both || node[k] == j;
            node[k] = node[k] == i ? j : node[k];
        }
        if (!has_both) {
            worst = fmax(worst, solid_badness(s->position[node[0]], s->position[node[1]],
                                              s->position[node[2]], s->position[node[3]], 0.0));
        }
    }
    return worst;
}

/* Tries to take node i away; `is_touched` are nodes whose stars have changed in this sweep. */
static bool collapse(solid *s, const star_table *t, int32_t i, double longest, bool *is_touched)
{
    int32_t best = -1;
    double least = collapse_limit;
    for (int32_t n = 4 * t->start[i]; n < 4 * t->start[i + 1]; ++n) {
        const int32_t j = s->tetrahedron[t->tetrahedron[n / 4]][n % 4];
        if (is_touched[j]) {
            return false;
        }
        const double badness = j != i ? collapse_badness(s, t, i, j, longest, least) : 3.0;
        if (badness < least) {
            least = badness;
            best = j;
        }
    }
    if (best < 0) {
        return false;
    }
    for (int32_t n = t->start[i]; n < t->start[i + 1]; ++n) {
        int32_t *node = s->tetrahedron[t->tetrahedron[n]];
        bool has_both = false;
        for (int k = 0; k < 4; ++k) {
            is_touched[node[k]] = true;
            has_both = has_both || node[k] == best;
        }
        for (int k = 0; k < 4; ++k) {
            node[k] = has_both ? -1 : node[k] == i ? best : node[k];
        }
    }
    return true;
}

/* One pass over the inner nodes; returns how many went, -1 when out of memory. */
static int32_t coarsen_once(solid *s, const double *depth, const bool *is_surface, int32_t most,
                            double longest)
{
    star_table t;
    if (!star_table_init(&t, s)) {
        return -1;
    }
    bool *is_touched = ss_memory_get((size_t)s->node_count, sizeof *is_touched);
    ss_keyed *order = ss_memory_get((size_t)s->node_count, sizeof *order);
    int32_t gone = is_touched != NULL && order != NULL ? 0 : -1;
    int32_t count = 0;
    for (int32_t i = 0; i < s->node_count && gone == 0; ++i) {
        if (!is_surface[i] && t.start[i + 1] > t.start[i]) {
            order[count++] = (ss_keyed){depth[i], i};
        }
    }
    if (count > 0) {
        qsort(order, (size_t)count, sizeof *order, ss_compare_keyed);
    }
    for (int32_t k = 0; k < count && gone < most; ++k) {
        gone += !is_touched[order[k].index] && collapse(s, &t, order[k].index, longest, is_touched);
    }
    int32_t kept = 0;
    for (int32_t e = 0; e < s->tetrahedron_count; ++e) {
        if (s->tetrahedron[e][0] >= 0) {
            memmove(s->tetrahedron[kept++], s->tetrahedron[e], sizeof s->tetrahedron[e]);
        }
    }
    s->tetrahedron_count = kept;
    ss_memory_free(order);
    ss_memory_free(is_touched);
    star_table_fini(&t);
    return gone;
}

/* Nodes that no tetrahedron has any more go; the others keep their order. */
static bool drop_unused(solid *s)
{
    int32_t *number = ss_memory_get((size_t)s->node_count, sizeof *number);
    if (number == NULL) {
        return false;
    }
    for (int32_t e = 0; e < s->tetrahedron_count; ++e) {
        for (int k = 0; k < 4; ++k) {
            number[s->tetrahedron[e][k]] = 1;
        }
    }
    int32_t count = 0;
    for (int32_t i = 0; i < s->node_count; ++i) {
        if (number[i] != 0) {
            ss_copy3(s->position[count], s->position[i]);
            number[i] = count++;
        }
    }
    for (int32_t e = 0; e < s->tetrahedron_count; ++e) {
        for (int k = 0; k < 4; ++k) {
            s->tetrahedron[e][k] = number[s->tetrahedron[e][k]];
        }
    }
    s->node_count = count;
    ss_memory_free(number);
    return true;
}

bool solid_coarsen(solid *s, const double *depth, int32_t node_count, double longest)
{
    star_table t;
    if (!star_table_init(&t, s)) {
        return false;
    }
    find_surface(s, &t); /* which does not change */
    int32_t left = s->node_count - node_count;
    int32_t gone = 1;
    while (left > 0 && gone > 0) {
        gone = coarsen_once(s, depth, t.is_surface, left, longest);
        left -= gone;
    }
    star_table_fini(&t);
    return gone >= 0 && drop_unused(s);
}
