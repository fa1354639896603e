/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Sets of nodes and values per node: what a checked region, field or data file means on the mesh.
 *
 * In: checked nodes of the tree, the transformed mesh in metres, data files beside the scene
 * (strangers' input: bounded, every line checked). Out: masks and arrays over the mesh's nodes or
 * elements. Borders belong to a region, with a tolerance of 1e-9 of the body's diagonal, so that a
 * border at 20 mm takes the node at 0.02 m. Used inside scene/ only. Thread: set-up only.
 */
#include "scene/scene.h"
#include "scene/schema.h"

typedef struct ss_scene_space {
    ss_scene_report *report;
    const char *folder; /* of the scene, "" or ending in / */
    const ss_mesh *mesh;
    ss_scene *scene;  /* whose doubts are noted */
    double tolerance; /* m */
    uint8_t *mask;    /* scratch, node_count */
} ss_scene_space;

/* `folder` and a path of a scene joined; false when too long. */
bool ss_scene_join_path(const char *folder, const char *path, char *out, size_t size);

/* The nodes of the one region among `map`'s keys as 1 in space->mask; how many, or -1 after a
 * fault (also when none is taken). */
int32_t ss_scene_select(ss_scene_space *space, ss_scene_node *map);
/* A value per node of `row`'s field, given by file or regions; false after a fault. Where the row
 * takes elements, a file may give a value per element (ss_mesh_element_count) instead: then
 * *out_is_element is true and out_element (else unused, may be NULL) filled. */
bool ss_scene_read_field(ss_scene_space *space, const ss_scene_row *row, ss_scene_node *node,
                         double *out_value, double *out_element, bool *out_is_element);
/* The same by link, where the field's file has the header node,node,value: how many links, with
 * *out_link to be freed; 0 when it is no such file, -1 after a fault. */
int32_t ss_scene_read_links(ss_scene_space *space, const ss_scene_row *row, ss_scene_node *node,
                            ss_param_link **out_link);
/* A unit vector per element (ss_mesh_element_count) by file; false after a fault. */
bool ss_scene_read_directions(ss_scene_space *space, ss_scene_node *node,
                              double (*out_direction)[3]);
/* Rows x,y,z in units of `metres`: exactly `count` of them, into out_position; false after a fault.
 * Needs no mesh. */
bool ss_scene_read_points(ss_scene_space *space, ss_scene_node *node, double metres, int32_t count,
                          double (*out_position)[3]);
/* Rows node,ux,uy,uz: out_displacement (3 per node of the mesh; NaN: an empty cell, a free axis),
 * and space->mask 1 for the nodes named. How many, or -1 after a fault. */
int32_t ss_scene_read_displacement(ss_scene_space *space, ss_scene_node *node,
                                   double (*out_displacement)[3]);
