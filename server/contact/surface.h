/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Private to contact/: the layout of a contact surface, shared by subdivide.c (rows), surface.c
 * (create, hierarchy), curvature.c, query.c (forces) and
 * contacts.c.
 *
 * A triangle's samples do not carry rows of their own. Its level-2 Loop points (15, on the
 * triangular grid i + j <= 4) do, over its n control nodes; a sample is a fixed convex combination
 * of three of these points. So x_q = sum_p c_qp sum_i C_pi P_i with one C of 15 x n (n = 12 where
 * all is regular) instead of 64 x 12 rows, and triangles of equal local topology share one C.
 */
#include "contact/contact.h"

enum {
    SS_GRID_POINTS = 15, /* level-2 points of a triangle */
    SS_GRID_ROW = 16,    /* the same, padded: 64 bytes of float */
    SS_GRID_FACETS = 16, /* level-2 facets of a triangle */
    SS_MAX_PARTS = 4,    /* splits of a facet's edge: 256 samples a triangle at most */
    SS_MAX_CONTROLS = 3 + 3 * SS_MAX_VALENCE,
    SS_TREE_LEAF = 8,  /* triangles of a leaf at most */
    SS_TREE_STACK = 64 /* deeper than any tree over 2^31 triangles */
};

/* Four lanes, x y z 0 of a node; the loose one loads and stores unaligned node arrays. */
typedef ss_real ss_wide __attribute__((vector_size(4 * sizeof(ss_real))));
typedef ss_real ss_wide_loose
    __attribute__((vector_size(4 * sizeof(ss_real)), aligned(sizeof(ss_real)), may_alias));

#ifdef SOFTSIM_DOUBLE
typedef int64_t ss_wide_mask __attribute__((vector_size(32)));
#else
typedef int32_t ss_wide_mask __attribute__((vector_size(16)));
#endif

/* Lane by lane; a NaN in `x` is passed over. */
static inline void ss_wide_lower(ss_wide *least, const ss_wide *x)
{
    const ss_wide_mask is_less = *x < *least;
    *least = (ss_wide)(((ss_wide_mask)*x & is_less) | ((ss_wide_mask)*least & ~is_less));
}

static inline void ss_wide_raise(ss_wide *most, const ss_wide *x)
{
    const ss_wide_mask is_more = *x > *most;
    *most = (ss_wide)(((ss_wide_mask)*x & is_more) | ((ss_wide_mask)*most & ~is_more));
}

/* Where a triangle's samples lie: the same for all triangles of a surface. */
typedef struct ss_grid {
    int32_t facet_count;                          /* 16; 1 for centroids only */
    int32_t part_count;                           /* samples of a facet, m^2 */
    int32_t weight_count;                         /* weight samples of a triangle: 4 or 1 */
    uint8_t facet[SS_GRID_FACETS][3];             /* points of a facet */
    ss_real part[SS_MAX_PARTS * SS_MAX_PARTS][3]; /* weights of the facet's points */
    ss_real bary[SS_GRID_POINTS][3];              /* of a point in the triangle, by corner */
    uint8_t corner[3];                            /* the points at the triangle's corners */
} ss_grid;

/* Rows of the grid points over the control nodes: coefficient[control][SS_GRID_ROW]. */
typedef struct ss_patch {
    int32_t control_count;
    int32_t first; /* of its coefficients, in rows of SS_GRID_ROW */
} ss_patch;

/* Box over the deformed control nodes of what is below, lanes x y z 0. */
typedef struct ss_box {
    ss_wide low, high;
} ss_box;

struct ss_surface {
    int32_t node_count, triangle_count, leaf_count, patch_count;
    bool is_closed;
    double centre[3]; /* m, world; positions below are relative to it */
    double mean_edge; /* m */
    double size;      /* m, half the diagonal at rest */
    ss_grid grid;
    ss_real *rest; /* 4 a node */
    /* Triangles are numbered in the order of the tree's leaves. */
    int32_t *control_first; /* triangle_count + 1 */
    int32_t *control;       /* the first three are the triangle's corners */
    int32_t *patch_of;
    ss_real *area; /* m^2, at rest */
    ss_patch *patch;
    ss_real *coefficient;
    int32_t (*fan)[3];           /* of the first three controls: who shares a normal */
    ss_real (*fan_normal)[3];    /* out of the tissue, at rest */
    ss_real (*fan_curvature)[6]; /* xx xy xz yy yz zz, 1/m, at rest */
    /* Complete binary tree: node k has children 2k + 1, 2k + 2; leaves are the last leaf_count. */
    int32_t *leaf_node_first; /* leaf_count + 1 */
    int32_t *leaf_node;       /* distinct control nodes of the leaf's triangles */
    /* scratch of ss_surface_refit */
    ss_box *box;
    ss_real *fitted_u; /* the displacement that the boxes were fitted to, 4 a node */
    int64_t fit;       /* how often they were; 0: not yet */
    double moved;      /* m, no node had moved further since then at the last refit */
    double fit_moved;  /* m, nor between the last two fits */
};

static inline int32_t ss_leaf_first_triangle(const ss_surface *surface, int32_t leaf)
{
    return (int32_t)((int64_t)leaf * surface->triangle_count / surface->leaf_count);
}

/* The level-2 points of triangle `t`, relative to `origin` (which is relative to the centre). */
static inline void ss_surface_points(const ss_surface *surface, int32_t t, const ss_real *u,
                                     const ss_wide *origin, ss_wide point[SS_GRID_ROW])
{
    const ss_patch *patch = &surface->patch[surface->patch_of[t]];
    const ss_real *row = surface->coefficient + (int64_t)patch->first * SS_GRID_ROW;
    const int32_t *control = surface->control + surface->control_first[t];
    ss_wide sum[SS_GRID_POINTS];
    for (int p = 0; p < SS_GRID_POINTS; ++p) {
        sum[p] = (ss_wide){0};
    }
    for (int32_t i = 0; i < patch->control_count; ++i, row += SS_GRID_ROW) {
        const int64_t at = 4 * (int64_t)control[i];
        const ss_wide position = *(const ss_wide_loose *)(surface->rest + at) +
                                 *(const ss_wide_loose *)(u + at) - *origin;
        for (int p = 0; p < SS_GRID_POINTS; ++p) {
            sum[p] += row[p] * position;
        }
    }
    for (int p = 0; p < SS_GRID_POINTS; ++p) {
        point[p] = sum[p];
    }
}

/* The motions C du of the points of triangle `t`. */
static inline void ss_surface_moves(const ss_surface *surface, int32_t t, const ss_real *du,
                                    ss_wide move[SS_GRID_ROW])
{
    const ss_patch *patch = &surface->patch[surface->patch_of[t]];
    const ss_real *row = surface->coefficient + (int64_t)patch->first * SS_GRID_ROW;
    const int32_t *control = surface->control + surface->control_first[t];
    for (int32_t i = 0; i < patch->control_count; ++i, row += SS_GRID_ROW) {
        const ss_wide at = *(const ss_wide_loose *)(du + 4 * (int64_t)control[i]);
        for (int p = 0; p < SS_GRID_POINTS; ++p) {
            move[p] = i == 0 ? row[p] * at : move[p] + row[p] * at;
        }
    }
}

/* Adds C^T value to the control nodes of triangle `t` (4 ss_real a node). */
static inline void ss_surface_scatter(const ss_surface *surface, int32_t t,
                                      const ss_wide value[SS_GRID_ROW], ss_real *out)
{
    const ss_patch *patch = &surface->patch[surface->patch_of[t]];
    const ss_real *row = surface->coefficient + (int64_t)patch->first * SS_GRID_ROW;
    const int32_t *control = surface->control + surface->control_first[t];
    for (int32_t i = 0; i < patch->control_count; ++i, row += SS_GRID_ROW) {
        ss_wide sum[3] = {{0}, {0}, {0}};
        for (int p = 0; p < SS_GRID_POINTS; p += 3) {
            sum[0] += row[p] * value[p];
            sum[1] += row[p + 1] * value[p + 1];
            sum[2] += row[p + 2] * value[p + 2];
        }
        ss_wide_loose *at = (ss_wide_loose *)(out + 4 * (int64_t)control[i]);
        *at += sum[0] + sum[1] + sum[2];
    }
}

/* ---- subdivide.c ---- */

/* Half-edges of a triangle list: half-edge 3t + k runs from corner k to corner k + 1. The triangles
 * around a node are one fan, or more where the body touches itself. */
typedef struct ss_edges {
    int32_t triangle_count;
    const int32_t (*triangle)[3];
    int32_t *twin; /* of ss_mesh_pair_sides: the opposite half-edge, -1 on a boundary */
    int32_t *fan;  /* of the corner that each half-edge leaves */
    int32_t fan_count;
} ss_edges;

softsim_status ss_edges_init(ss_edges *edges, const ss_mesh *mesh, softsim_error *error);
void ss_edges_fini(ss_edges *edges);

/* Fills control_first, control, fan, patch_of, patch and coefficient; may turn the triangles'
 * corners (the first three controls). `triangle` lists the mesh's triangles in the surface's order.
 */
softsim_status ss_subdivide(const ss_edges *edges, const int32_t *triangle, bool is_linear,
                            ss_surface *surface);

/* ---- curvature.c ---- */

/* Makes fan_normal and fan_curvature. */
softsim_status ss_surface_curve(ss_surface *surface, const ss_mesh *mesh, const ss_edges *edges);
