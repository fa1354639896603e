/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside server/mesh only: boxes in space and a tree over them, for what lies near what: triangles
 * that cross, nodes on edges, rays, nearest points. Set-up only.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"

typedef struct ss_box {
    double low[3], high[3];
} ss_box;

/* A heap over boxes sorted along a Morton curve, padded to a power of two: leaf i is box leaf_count
 * + i, and stands for item[i]. */
typedef struct ss_tree {
    int32_t *item;
    ss_box *box;
    int32_t *label; /* of each box that of all items below it, -1: they differ; NULL: no labels */
    int32_t count, leaf_count;
} ss_tree;

/* Of nothing; grows by ss_box_add. */
void ss_box_init(ss_box *box);
void ss_box_add(ss_box *box, const double x[3]);
/* Of a triangle; false, and of nothing, where it has bad nodes or positions. */
bool ss_box_of_triangle(const ss_mesh *mesh, int32_t t, ss_box *out);
static inline bool ss_box_overlaps(const ss_box *a, const ss_box *b)
{
    return a->low[0] <= b->high[0] && b->low[0] <= a->high[0] && a->low[1] <= b->high[1] &&
           b->low[1] <= a->high[1] && a->low[2] <= b->high[2] && b->low[2] <= a->high[2];
}

/* Boxes of nothing are left out. False when out of memory. */
bool ss_tree_init(ss_tree *tree, const ss_box *box, int32_t count);
bool ss_tree_init_triangles(ss_tree *tree, const ss_mesh *mesh);
void ss_tree_fini(ss_tree *tree);
/* Gives each item a label, from 0, or -1: none. False when out of memory. */
bool ss_tree_set_labels(ss_tree *tree, const int32_t *label);
/* Hands each item whose box overlaps `box` to `take`; the visits that are left go down. */
void ss_tree_visit(const ss_tree *tree, const ss_box *box, int64_t *inout_visits,
                   void (*take)(void *what, int32_t item), void *what);
/* The same for the box of triangle t of `mesh`, without those of a label, from 0, and those whose
 * boxes lie on one side of the triangle's plane. */
void ss_tree_visit_others(const ss_tree *tree, const ss_mesh *mesh, int32_t t, int32_t label,
                          int64_t *inout_visits, void (*take)(void *what, int32_t item),
                          void *what);

/* The point of a triangle nearest to x (Ericson 2005, 5.1.5); its squared distance. */
double ss_triangle_nearest(const double x[3], const double a[3], const double b[3],
                           const double c[3], double out[3]);
/* The point nearest to x on the triangles of `mesh`, whose tree it is, and its triangle; the
 * distance. INFINITY, and nothing in out, without triangles. */
double ss_tree_nearest(const ss_tree *tree, const ss_mesh *mesh, const double x[3], double out[3],
                       int32_t *out_triangle);

/* Of the six rays from x along the axes, how many meet an odd number of triangles, and how many
 * none. A point inside a closed surface has six and none. */
typedef struct ss_rays {
    int odd_count, free_count;
} ss_rays;
ss_rays ss_tree_cast(const ss_tree *tree, const ss_mesh *mesh, const double x[3],
                     int64_t *inout_visits);

/* Do two triangles cross, as ss_mesh_find_crossings means it (selfcross.c)? */
bool ss_mesh_triangles_cross(const ss_mesh *mesh, int32_t s, int32_t t);
