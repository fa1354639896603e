/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside remeshing only: the surface that is remeshed (remesher.c), and what is done at one edge of
 * it (remesh_edges.c). remesh.c says the method. Sides are 3 t + c as everywhere; each has a mate
 * or -1.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"
#include "mesh/tree.h"

/* Of the length L that is wanted: longer edges are divided, shorter ones go. */
#define SS_REMESH_TOO_LONG  (4.0 / 3.0)
#define SS_REMESH_TOO_SHORT (4.0 / 5.0)
/* Triangles that there may be, in all: what needles are divided into has no bound by their area. */
#define SS_REMESH_MOST_TRIANGLES 8000000

typedef struct ss_remesher {
    int32_t node_count, node_room, triangle_count, triangle_room;
    double (*x)[3];
    uint64_t *groups; /* a bit for each that the node is in */
    bool *is_locked;
    int32_t *corner; /* a side that starts at the node */
    int32_t (*triangle)[3];
    int32_t *mate;
    bool *is_feature; /* of each side */
    double edge;
    bool is_full; /* SS_REMESH_MOST_TRIANGLES are there */
    const ss_mesh *given;
    ss_tree tree;
} ss_remesher;

/* Room for these counts, empty. False when out of memory, as of all below. */
bool ss_remesher_init(ss_remesher *r, int32_t node_count, int32_t triangle_count);
/* Room for one more node and two more triangles. */
bool ss_remesher_make_room(ss_remesher *r);
void ss_remesher_fini(ss_remesher *r);
/* Puts in the place of `to` what operations change of `from`. */
bool ss_remesher_copy(const ss_remesher *from, ss_remesher *to);
/* Packs triangles that are left, and the nodes they use, in order; finds mates and corners. */
bool ss_remesher_rebuild(ss_remesher *r);
void ss_remesher_join(ss_remesher *r, int32_t a, int32_t b);
double ss_remesher_length(const ss_remesher *r, int32_t a, int32_t b);

static inline int32_t ss_next_side(int32_t id)
{
    return id / 3 * 3 + (id % 3 + 1) % 3;
}

static inline int32_t ss_last_side(int32_t id)
{
    return id / 3 * 3 + (id % 3 + 2) % 3;
}

static inline int32_t ss_start_of(const ss_remesher *r, int32_t id)
{
    return r->triangle[id / 3][id % 3];
}

static inline int32_t ss_end_of(const ss_remesher *r, int32_t id)
{
    return r->triangle[id / 3][(id % 3 + 1) % 3];
}

static inline int32_t ss_third_of(const ss_remesher *r, int32_t id)
{
    return r->triangle[id / 3][(id % 3 + 2) % 3];
}

enum { SS_REMESH_MAX_RING = 48 };
/* What is around a node. That of more triangles is left until its neighbours have become fewer. */
typedef struct ss_ring {
    int32_t side[SS_REMESH_MAX_RING]; /* that start at the node, in order; from its border where it
                                         has one */
    int count;
    bool is_open;
    int features;       /* edges at the node */
    int32_t feature[2]; /* the other ends of the first two */
} ss_ring;

/* False where there are too many. */
bool ss_remesher_gather(const ss_remesher *r, int32_t node, ss_ring *g);
/* Would the triangle of this side be the other way up, flat (where it was flat already: less open
 * than the share `as_flat` of what it was) or too short, with its start at `x`? */
bool ss_remesh_turns_over(const ss_remesher *r, int32_t side, const double x[3], double as_flat);

/* Puts a node into the middle of a side and its mate. */
bool ss_remesh_divide(ss_remesher *r, int32_t id);
/* The start of a side goes to its end, where it may. */
void ss_remesh_collapse(ss_remesher *r, int32_t id);
/* The two triangles of a side change to the other diagonal, where that is better. */
void ss_remesh_flip(ss_remesher *r, int32_t id);
