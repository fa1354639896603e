/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Private to contact/: what a touch keeps between its calls (touch.c, contacts.c). */
#include "contact/surface.h"

/* A tool pose in the surface's frame (world axes, origin at the surface's centre). */
typedef struct ss_frame {
    const ss_shape *shape;
    double orientation[4];
    ss_wide origin; /* m, the tool's, relative to the surface's centre */
    /* Sphere and capsule: distance to the segment of half-length `core` along `axis`. */
    bool is_round;
    ss_real axis[3], core, radius;
} ss_frame;

/* A triangle in reach, with balls that held its parts at the gather. */
typedef struct ss_candidate {
    ss_real centre[3]; /* of the ball that holds its grid points and corners */
    ss_real radius;
    ss_real facet_radius; /* no facet reached further from its centroid; < 0 not known yet */
    int32_t triangle;
} ss_candidate;

/* A sample inside the tool. */
typedef struct ss_sample {
    ss_real r[3];  /* m, from the tool's origin, world axes */
    ss_real depth; /* m, -d > 0 */
    ss_real n[3];  /* out of the tool */
    int32_t code;  /* facet * part_count + part */
} ss_sample;

/* The samples of one triangle: sample[first] .. sample[next group's first - 1]. */
typedef struct ss_group {
    int32_t triangle;
    int32_t first, count;
} ss_group;

/* A triangle with source weight: its 1 or 4 weight samples. */
typedef struct ss_source {
    int32_t triangle;
    int32_t slot[3];  /* of its corners in the list of touched nodes, -1 none */
    ss_real slope[4]; /* -A_s phi'(d_s) >= 0, m */
    ss_real n[4][3], r[4][3];
} ss_source;

/* The path of the tool's origin, start .. start + along, relative to the surface's centre. */
typedef struct ss_sweep {
    double start[3], along[3];
    double square; /* |along|^2 */
} ss_sweep;

struct ss_touch {
    const ss_surface *surface;
    ss_shape shape;
    double delta, stiffness;
    double slack;  /* m: nodes may move so far after the gather */
    double spare;  /* m: the tool may be so far off the gathered path */
    double margin; /* m, over rounding when something is left out */
    double bounding_radius;
    int32_t station_count; /* contacts along the axis, from station_low to station_high */
    double station_low, station_high;

    /* gather: what the candidates are complete for */
    ss_sweep sweep;
    ss_tool_pose middle; /* the tool halfway; no point of it is further than half_motion */
    double half_motion;
    bool is_gathered;
    ss_candidate *candidate;
    int32_t candidate_count;
    int32_t *reach;   /* increasing */
    ss_real *reach_u; /* their displacement at the gather, 4 a node */
    int32_t reach_count;
    uint64_t *mark; /* one bit a node, clear between calls */

    /* weigh */
    double *node_weight; /* every node, clear between calls */
    int32_t *node_slot;
    int32_t *weight_node;
    double *weight;
    int32_t weight_count;
    ss_source *source;
    int32_t source_count, source_capacity;

    /* penalty */
    ss_sample *sample;
    int32_t sample_count, sample_capacity;
    ss_group *group;
    int32_t group_count;
    int32_t dropped_from; /* candidate from which samples were no longer kept, or the count */
};

void ss_frame_set(ss_frame *frame, const ss_touch *touch, const ss_tool_pose *pose);
/* Wide values go by pointer: passed by value they would need one ABI for all processors. */

/* Signed distance of the point at `r` from the tool's origin, and its gradient (may be NULL). */
double ss_frame_distance(const ss_frame *frame, const ss_real r[3], double out_normal[3]);
/* Position of sample `code` among a triangle's points. */
static inline void ss_grid_sample(const ss_grid *grid, int32_t facet, int32_t part,
                                  const ss_wide point[SS_GRID_ROW], ss_wide *out)
{
    const uint8_t *f = grid->facet[facet];
    const ss_real *c = grid->part[part];
    *out = c[0] * point[f[0]] + c[1] * point[f[1]] + c[2] * point[f[2]];
}
