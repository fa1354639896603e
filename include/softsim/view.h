/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What a viewer is told: the scene, the body's surface at rest, how its nodes are displaced, and a
 * scalar to colour them by. They mirror scene_t, mesh_topology_t, mesh_delta_t and mesh_field_t.
 *
 * SI units, world frame; utime_us is the server's own clock. Arrays and texts belong to whoever
 * filled them in; those that a client's callback gets are valid during the call.
 */
#include <stdint.h>

#include "softsim/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Form of a tool, in scene_t's numbers. */
#define SOFTSIM_TOOL_LIST(X)                                                                       \
    X(NONE, 0, "none")                                                                             \
    X(SPHERE, 1, "sphere")                                                                         \
    X(CAPSULE, 2, "capsule")                                                                       \
    X(CYLINDER, 3, "cylinder")                                                                     \
    X(CONE, 4, "cone")                                                                             \
    X(BOX, 5, "box")                                                                               \
    X(CONVEX, 6, "convex")

typedef enum softsim_tool_form {
#define X(name, value, text) SOFTSIM_TOOL_##name = (value),
    SOFTSIM_TOOL_LIST(X)
#undef X
} softsim_tool_form;

#define SOFTSIM_MAX_LIVE 64 /* parameters that the command set reaches */

typedef struct softsim_scene_report {
    int64_t utime_us;
    int32_t seq;
    int32_t topology; /* that the mesh messages name; 0: none are sent */
    softsim_tool_form form[SOFTSIM_MAX_PROBES];
    double size[SOFTSIM_MAX_PROBES][3];      /* m: radius; radius, length along z (of a capsule
                                                without its ends); edges */
    int32_t hull_count[SOFTSIM_MAX_PROBES];  /* vertices of convex tools */
    const float *hull;                       /* m, x y z in the tool's frame, probe by probe */
    int32_t parameter_count;                 /* at most SOFTSIM_MAX_LIVE */
    const char *parameter[SOFTSIM_MAX_LIVE]; /* "PATH=VALUE LOW HIGH UNIT"; of a choice LOW and HIGH
                                               are the numbers of its first and last word, which
                                               UNIT lists: "hold|linear|local" */
    const char *name;                        /* the scene's file, without its folder */
    const char *model;                       /* as in the scene */
    const char *field;                       /* that mesh_field_t carries, or "none" */
} softsim_scene_report;

/* A piece of the surface at rest: nodes first_node .. first_node + node_chunk - 1, and triangles
 * first_triangle .. first_triangle + triangle_chunk - 1. */
typedef struct softsim_topology_chunk {
    int64_t utime_us;
    int32_t seq, topology;
    int32_t node_count, triangle_count; /* of the whole */
    int32_t first_node, node_chunk, first_triangle, triangle_chunk;
    float scale;              /* m per count of a displacement */
    const int32_t *file_node; /* -1: in no file, put on an edge by the model */
    const uint8_t *node_flag; /* bit 0: fixed */
    const float *rest;        /* m, 3 a node */
    const int32_t *triangle;  /* 3 a triangle, below node_count */
} softsim_topology_chunk;

typedef struct softsim_mesh_delta {
    int64_t utime_us, step;
    int32_t seq, topology, count;
    const int32_t *node;         /* >= 0; compare with the topology's node_count */
    const int16_t *displacement; /* from rest, in counts of the topology's scale, 3 a node */
} softsim_mesh_delta;

typedef struct softsim_mesh_field {
    int64_t utime_us, step;
    int32_t seq, topology, first_node, count;
    const char *name, *unit;
    float low, high;      /* what -32767 and 32767 stand for */
    const int16_t *value; /* of nodes first_node .. first_node + count - 1 */
} softsim_mesh_field;

#ifdef __cplusplus
}
#endif
