/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Private to contact/: a convex mesh (convex.c) and the cells that know which of its planes,
 * triangles and edges can matter where (convex_cells.c). Written once, at load; any thread reads
 * it.
 */
#include "contact/shape.h"
#include "rt/vec.h"

/* A box of space: eight smaller ones, or a leaf's list. */
typedef struct ss_convex_cell {
    int32_t child;                      /* the first of the eight; 0: a leaf */
    int32_t plane, triangle, edge, end; /* where its planes, ... begin in the list */
} ss_convex_cell;

struct ss_convex {
    int32_t vertex_count, triangle_count, plane_count, edge_count;
    double (*vertex)[3];
    int32_t (*triangle)[3];
    int32_t *plane_of; /* of a triangle */
    int32_t (*edge)[2];
    double (*plane)[4]; /* outward unit normal, offset */
    double bulge;       /* e, m */
    double centre[3];   /* mean of the vertices */
    double bounding_radius, inradius;
    double low[3], high[3];

    /* Cells; the first holds all others. */
    double middle[3], half[3]; /* of the first, m */
    double per_cell[3];        /* 1/m, one over the edges of the smallest */
    ss_convex_cell *cell;
    uint16_t *list;
};

static inline double ss_convex_plane_value(const ss_convex *convex, int32_t f, const double x[3])
{
    const double *plane = convex->plane[f];
    return plane[0] * x[0] + plane[1] * x[1] + plane[2] * x[2] - plane[3];
}

/* Squared distance of x from edge `e`, and the way from its nearest point. RT-safe. */
static inline double ss_convex_edge_square(const ss_convex *convex, int32_t e, const double x[3],
                                           double out_away[3])
{
    const double *a = convex->vertex[convex->edge[e][0]];
    double along[3];
    ss_sub3(along, convex->vertex[convex->edge[e][1]], a);
    ss_sub3(out_away, x, a);
    const double square = ss_dot3(along, along);
    const double t = square > 0.0 ? ss_dot3(out_away, along) / square : 0.0;
    ss_madd3(out_away, out_away, t < 0.0 ? 0.0 : t > 1.0 ? -1.0 : -t, along);
    return ss_dot3(out_away, out_away);
}

/* ---- cells ---- */

/* Divides the space about a mesh with planes; false without memory. */
bool ss_convex_divide(ss_convex *convex);
/* The leaf that holds x; NULL beyond all cells. RT-safe. */
const ss_convex_cell *ss_convex_find_cell(const ss_convex *convex, const double x[3]);
