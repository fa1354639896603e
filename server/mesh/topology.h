/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside server/mesh only: which elements share an edge, a face or all their nodes, found by
 * sorting tuples of node numbers; and connected parts. Elements whose nodes are out of range or
 * repeat are left out, so that no function here follows a bad index.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"

/* An edge, a face or an element: its nodes ascending, unused places 0, and where it came from. */
typedef struct ss_mesh_tuple {
    int32_t node[4];
    int32_t id;
} ss_mesh_tuple;

typedef struct ss_mesh_tuples {
    ss_mesh_tuple *tuple; /* sorted by nodes, then id */
    int64_t count;
} ss_mesh_tuples;

/* Is it finite, and so near that lengths, areas and volumes are? Readers refuse others. */
#define SS_MESH_FARTHEST 1e60
bool ss_mesh_is_place(const double x[3]);

bool ss_mesh_has_good_nodes(const ss_mesh *mesh, const int32_t *node, int count);

/* All of these return false when out of memory; release with ss_mesh_tuples_fini. */
bool ss_mesh_list_triangle_edges(const ss_mesh *mesh, ss_mesh_tuples *out); /* id 3 t + corner */
bool ss_mesh_list_triangles(const ss_mesh *mesh, ss_mesh_tuples *out);
bool ss_mesh_list_quad_edges(const ss_mesh *mesh, ss_mesh_tuples *out); /* id 4 q + corner */
bool ss_mesh_list_quads(const ss_mesh *mesh, ss_mesh_tuples *out);
bool ss_mesh_list_tetrahedron_edges(const ss_mesh *mesh, ss_mesh_tuples *out); /* id 6 e + side */
bool ss_mesh_list_tetrahedron_faces(const ss_mesh *mesh, ss_mesh_tuples *out); /* id 4 e + corner */
bool ss_mesh_list_tetrahedra(const ss_mesh *mesh, ss_mesh_tuples *out);
void ss_mesh_tuples_fini(ss_mesh_tuples *tuples);

/* The end of the run of equal tuples that starts at `begin`. */
int64_t ss_mesh_run_end(const ss_mesh_tuples *tuples, int64_t begin);

/* Do as many of these triangles run along the edge, tuples begin to end, one way as the other? */
bool ss_mesh_is_even(const ss_mesh *mesh, const ss_mesh_tuples *edges, int64_t begin, int64_t end);
/* Node of corner c of triangle t runs to the node of corner c + 1; is that ascending? */
bool ss_mesh_edge_is_ascending(const ss_mesh *mesh, int32_t id);

/* Thirds of the areas of a quad's halves, and of their vectors, to its corners: the mean of both
 * ways of cutting, or the one that leaves no half flat or folded. The nodes must be good. */
void ss_mesh_share_quad(const ss_mesh *mesh, const int32_t *quad, double out_area[4],
                        double out_vector[4][3]);
/* The halves of a quad by its shape alone. */
void ss_mesh_cut_quad(const ss_mesh *mesh, const int32_t *quad, int32_t out_triangle[2][3]);
/* Winds quad q and its halves the other way; u, w and the diagonal stay. */
void ss_mesh_turn_quad(ss_mesh *mesh, int32_t q);
/* Turns the quads' corners so that u and w run on over shared sides, and fills in the triangles,
 * for which there is room. False when out of memory. */
bool ss_mesh_arrange_quads(ss_mesh *mesh);

/* How near to each other nodes are coincident: never below the rounding of coordinates. */
double ss_mesh_twin_reach(const ss_mesh *mesh, double mean_edge);
/* The lower node within `reach` of each node, or -1; that node has none itself. Only among those
 * that `is_used` is true of; NULL: all. False when out of memory. */
bool ss_mesh_find_twins(const ss_mesh *mesh, double reach, const bool *is_used, int32_t *out_twin);

/* Below these times the square and cube of the mean edge, elements have no area or volume. */
#define SS_MESH_FLAT_AREA   1e-6
#define SS_MESH_FLAT_VOLUME 1e-9

/* Union-find with path halving over 0 .. count - 1. */
void ss_mesh_union_init(int32_t *parent, int32_t count);
int32_t ss_mesh_union_find(int32_t *parent, int32_t i);
void ss_mesh_union_join(int32_t *parent, int32_t a, int32_t b);

/* Numbers the connected parts from 0 in the order of their lowest node: out_part has node_count
 * values, -1 for loose nodes. By triangles alone, or with the tetrahedra. Returns their number. */
int32_t ss_mesh_find_parts(const ss_mesh *mesh, bool by_tetrahedra, int32_t *out_part);

/* A connected part of the surface. */
typedef struct ss_mesh_part {
    double box_min[3], box_max[3];
    double volume;
    bool is_open;
} ss_mesh_part;

/* By their boxes. */
bool ss_mesh_part_is_within(const ss_mesh_part *inner, const ss_mesh_part *outer);

/* More parts than this are not compared with one another. */
enum { SS_MESH_MAX_PARTS = 1000 };

/* Fills `parts` (numbered by `part`, from ss_mesh_find_parts) and tells of each whether it is
 * closed with a negative volume and no cavity: out_is_inside_out may be NULL; returns whether any.
 */
bool ss_mesh_measure_parts(const ss_mesh *mesh, const int32_t *part, int32_t part_count,
                           const ss_mesh_tuples *edges, ss_mesh_part *parts,
                           bool *out_is_inside_out);

/* Corners of the face opposite corner c, counter-clockwise from outside when the volume is
 * positive; the fourth place is unused. */
extern const int8_t ss_mesh_tetrahedron_face[4][4];
/* Surface of the tetrahedra, outward; sets triangle and triangle_count. */
bool ss_mesh_extract_surface(ss_mesh *mesh);
/* Sets is_closed. */
bool ss_mesh_find_closed(ss_mesh *mesh);
