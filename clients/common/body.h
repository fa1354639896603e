/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The body as the mesh messages tell it, and what one browser has been told of it.
 *
 * Pieces of a topology are gathered until all nodes and triangles are there; a topology of another
 * number starts afresh. Deltas carry absolute displacements in counts, so the newest is what holds,
 * and what a lost message left out heals by the server's rolling refresh.
 * The nodes stand in a list by when they last changed, the newest first, each with the number of
 * that change; of a browser only the number is kept up to which it has all. A frame for it is the
 * list's beginning: a browser that is slow, or comes late, gets what it lacks and nothing twice,
 * and what it costs grows with what it gets, not with the body.
 *
 * Frames are little-endian, as browsers read them:
 *   topology  u8 1, 3 x 0, u32 nodes, u32 triangles, f32 metres per count,
 *             f32 rest[3 nodes], u32 triangle[3 triangles], u8 flag[nodes]
 *   delta     u8 2, 3 x 0, u32 count, u32 node[count], i16 displacement[3 count]; in no order
 *   field     u8 3, 3 x 0, u32 nodes, f32 low, f32 high, char name[32], char unit[32] (both end
 *             with 0), i16 value[nodes], -32767 for low, 32767 for high
 * Rejected: the whole surface in each frame (at 60 Hz a hundred times the bytes of what a tool
 * moves), passing the messages on as they come (a browser that misses one stays wrong for up to a
 * second, a late one has no surface for two), and a copy of the counts for each browser (all nodes
 * are compared, for each, under the lock that poses wait for). Thread: one at a time.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "softsim/view.h"

enum { SS_BODY_MAX_NODES = 4000000, SS_BODY_MAX_TRIANGLES = 8000000 };

typedef struct ss_body_view {
    int32_t topology;    /* 0: none was heard of */
    uint32_t generation; /* grows with each complete topology, and with each session of it */
    bool is_complete;
    int32_t node_count, triangle_count;
    float scale;
    uint8_t *block; /* has all arrays */
    float (*rest)[3];
    int32_t (*triangle)[3];
    uint8_t *flag;
    uint8_t *has_node, *has_triangle;
    int32_t nodes_missing, triangles_missing;
    int16_t (*displacement)[3];
    uint64_t change;        /* grows with each delta that changes anything */
    uint64_t *node_change;  /* of the last one that changed the node; 0: none */
    int32_t *newer, *older; /* the list, of nodes with a change; -1: its end */
    int32_t newest;
    int16_t *field;
    float field_low, field_high;
    char field_name[32], field_unit[32];
    uint64_t field_change; /* 0: no field was heard of */
} ss_body_view;

/* What one browser has. */
typedef struct ss_body_copy {
    uint32_t generation; /* 0: nothing */
    uint64_t change, field_change;
    bool is_turn_of_field; /* a slow browser gets both in turn */
} ss_body_copy;

/* False: out of memory, or more nodes than are shown; then it is as if nothing had come. */
bool ss_body_take_topology(ss_body_view *body, const softsim_topology_chunk *chunk);
void ss_body_take_delta(ss_body_view *body, const softsim_mesh_delta *delta);
void ss_body_take_field(ss_body_view *body, const softsim_mesh_field *field);
/* Another server speaks, of what may be the same body: nothing is displaced until it says so, and
 * browsers begin afresh. */
void ss_body_begin_session(ss_body_view *body);
void ss_body_free(ss_body_view *body);

/* Has the browser the surface at rest, as far as it is known? */
bool ss_body_has_topology(const ss_body_view *body, const ss_body_copy *copy);
/* The next frame for it, to be freed with free(), with `before` bytes of room in front of it; NULL
 * when it has all there is, or without memory. */
uint8_t *ss_body_frame(const ss_body_view *body, ss_body_copy *copy, size_t before,
                       size_t *out_size);
