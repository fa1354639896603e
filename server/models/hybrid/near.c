/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/hybrid/hybrid.h"
/*
 * The near particles, copied side by side.
 *
 * What the kernels walk through of a layer of tens of thousands, ties, rows, moments and states of
 * some hundreds, lies scattered over megabytes: a few lines of memory here and there, of which the
 * smallest cache holds half. It is gathered whenever one came or went, which takes an eighth to a
 * half of an evaluation of forces and is seldom; a node or an offset that changes is written where
 * it lies. Points come first, in the order of their blocks, then those that are near alone, with
 * neighbours by their places here. At 230 awake of HM1's 28,000 the passes over particles take a
 * sixth less time so.
 */
#include <string.h>

/* After the last pair: eight scales are read at a time. */
enum { SPARE_PAIRS = 8 };

bool ss_hybrid_create_near(ss_hybrid *hybrid)
{
    const ss_layer *layer = hybrid->layer;
    ss_layer_near *near = &hybrid->near_rows;
    int64_t most = 0;
    for (int32_t p = 0; p < layer->count; ++p) {
        const int64_t pairs = layer->pair_first[p + 1] - layer->pair_first[p];
        most = pairs > most ? pairs : most;
    }
    const int64_t points = hybrid->max_points;
    const int64_t all = layer->pair_first[layer->count];
    const size_t pairs = (size_t)(points * most < all ? points * most : all) + SPARE_PAIRS;
    const int64_t around = points * (most + 1);
    const size_t count = (size_t)(around < layer->count ? around : layer->count);
    const size_t ties = count * SS_LAYER_TIE;
    ss_arena *arena = &hybrid->arena;
    SS_ARENA_TAKE(arena, SS_ROOM(count, near->node_of), SS_ROOM(4 * count, near->offset),
                  SS_ROOM(count + 1, near->tie_first), SS_ROOM(ties, near->tie_node),
                  SS_ROOM(ties, near->tie), SS_ROOM((size_t)points + 1, near->pair_first),
                  SS_ROOM(pairs, near->neighbour), SS_ROOM(4 * pairs, near->pair),
                  SS_ROOM(pairs, near->pair_scale), SS_ROOM(8 * (size_t)points, near->moment),
                  SS_ROOM((size_t)layer->count, hybrid->place_of),
                  SS_ROOM(8 * count, hybrid->state), SS_ROOM(4 * count, hybrid->particle_force));
    return ss_arena_status(arena) == SOFTSIM_OK;
}

static void put_node(ss_hybrid *hybrid, int32_t p, int32_t place)
{
    ss_layer_near *near = &hybrid->near_rows;
    near->node_of[place] = hybrid->node_of[p];
    memcpy(near->offset + 4 * (ptrdiff_t)place, hybrid->offset + 4 * (ptrdiff_t)p,
           4 * sizeof *near->offset);
}

void ss_hybrid_move_near(ss_hybrid *hybrid, int32_t p)
{
    if (!hybrid->is_near_old && hybrid->particle[p].near >= 0) {
        put_node(hybrid, p, hybrid->place_of[p]);
    }
}

/* Where particle p moves: its node, or its tie and what it is beside it. */
static void gather_tie(ss_hybrid *hybrid, int32_t p, int32_t place)
{
    const ss_layer *layer = hybrid->layer;
    ss_layer_near *near = &hybrid->near_rows;
    const int32_t from = layer->tie_first[p];
    const int32_t to = near->tie_first[place];
    const int32_t count = layer->tie_first[p + 1] - from;
    put_node(hybrid, p, place);
    memcpy(near->tie_node + to, layer->tie_node + from, (size_t)count * sizeof *near->tie_node);
    memcpy(near->tie + to, layer->tie + from, (size_t)count * sizeof *near->tie);
    near->tie_first[place + 1] = to + count;
}

/* Rows of point k, particle p. */
static void gather_pairs(ss_hybrid *hybrid, int32_t p, int32_t k)
{
    const ss_layer *layer = hybrid->layer;
    ss_layer_near *near = &hybrid->near_rows;
    const ptrdiff_t from = layer->pair_first[p];
    const ptrdiff_t to = near->pair_first[k];
    const int32_t count = layer->pair_first[p + 1] - layer->pair_first[p];
    for (int32_t t = 0; t < count; ++t) {
        near->neighbour[to + t] = hybrid->place_of[layer->neighbour[from + t]];
    }
    memcpy(near->pair + 4 * to, layer->pair + 4 * from, 4 * (size_t)count * sizeof *near->pair);
    memcpy(near->pair_scale + to, layer->pair_scale + from,
           (size_t)count * sizeof *near->pair_scale);
    memcpy(near->moment + 8 * (ptrdiff_t)k, layer->moment + 8 * (ptrdiff_t)p,
           8 * sizeof *near->moment);
    near->pair_first[k + 1] = (int32_t)to + count;
}

void ss_hybrid_gather_near(ss_hybrid *hybrid)
{
    ss_layer_near *near = &hybrid->near_rows;
    if (!hybrid->is_near_old) {
        return;
    }
    hybrid->is_near_old = false;
    near->count = near->point_count = hybrid->point_count;
    for (int32_t k = 0; k < hybrid->point_count; ++k) {
        hybrid->place_of[hybrid->point[k]] = k;
        gather_tie(hybrid, hybrid->point[k], k);
    }
    for (int32_t k = 0; k < hybrid->near_count; ++k) {
        const int32_t p = hybrid->near[k];
        if (hybrid->particle[p].point < 0) {
            hybrid->place_of[p] = near->count;
            gather_tie(hybrid, p, near->count++);
        }
    }
    for (int32_t k = 0; k < hybrid->point_count; ++k) {
        gather_pairs(hybrid, hybrid->point[k], k);
    }
}
