/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Private to contact/: what a contact query keeps between its calls (broad_phase.c, query.c,
 * contacts.c). */
#include "contact/frame.h"
#include "contact/surface.h"

/* A triangle in reach, with balls that held its parts at the broad phase. */
typedef struct ss_candidate {
    ss_real centre[3]; /* of the ball that holds its grid points and corners */
    ss_real radius;
    ss_real facet_radius; /* no facet reached further from its centroid; < 0 not known yet */
    int32_t triangle;
} ss_candidate;

/* A sample inside the tool. */
typedef struct ss_sample {
    ss_real r[3];         /* m, from the tool's origin, world axes */
    ss_real depth;        /* m, D > 0 */
    ss_real n[3];         /* out of the tool, unit: of -grad D */
    ss_real lean;         /* |grad D| */
    int32_t sample_index; /* facet * part_count + part */
} ss_sample;

/* What friction has made of it (friction.c). */
typedef struct ss_rub {
    ss_real s[3]; /* m, s': along the surface, from the anchor to the sample */
    ss_real hold; /* |s'|/|s|: 1 sticks */
} ss_rub;

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

/* Where the tool's middle was found outside of the tissue. */
typedef struct ss_outside {
    bool is_known;
    double middle[3];
    double clear; /* m, no point of the surface was nearer to it */
    int64_t fit;  /* of the surface then, */
    double moved; /* m, and how far nodes had moved since */
} ss_outside;

typedef struct ss_contact_friction ss_contact_friction;

struct ss_contact_query {
    const ss_surface *surface;
    ss_shape shape;
    double delta, stiffness;
    ss_real stiffening_depth; /* m */
    double node_slack;        /* m: nodes may move so far after the broad phase */
    double path_slack;        /* m: the tool may be so far off the swept path */
    double margin;            /* m, over rounding when something is left out */
    double bounding_radius;
    double centre[3];      /* the middle of the tool, in its frame */
    double centre_depth;   /* m, how deep that is in the tool */
    int32_t station_count; /* contacts along the axis, from station_low to station_high */
    double station_low, station_high;

    /* broad phase: what the candidates are complete for */
    ss_sweep sweep;
    ss_tool_pose middle; /* the tool halfway; no point of it is further than half_motion */
    double half_motion;
    bool has_candidates;
    int64_t fit;      /* of the hierarchy that the broad phase was made with, */
    double fit_moved; /* m, and how far nodes had moved since that fit */
    ss_candidate *candidate;
    int32_t candidate_count;
    int32_t *candidate_node; /* that move the candidates, increasing */
    ss_real *candidate_u;    /* their displacement at the broad phase, 4 a node */
    int32_t candidate_node_count;
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
    int32_t dropped_from;     /* candidate from which samples were no longer kept, or the count */
    ss_real max_facet_radius; /* m, no facet near the tool reaches further from its centroid */

    ss_outside outside;

    /* friction; NULL without */
    ss_contact_friction *friction;
    ss_rub *rub; /* of the samples */
};

/* ---- query.c ---- */

/* A sample deeper than this share of the tool's inradius is so many times as stiff. */
#define SS_CONTACT_QUERY_STIFFENING_FROM 0.3
enum { SS_CONTACT_QUERY_STIFFENING = 10 };

/* Of the deepest sample's depth, over which a sample comes to count in the tangent. */
#define SS_CONTACT_QUERY_RISE 0.05

/* c(D) |grad D| of a sample. */
static inline ss_real ss_contact_query_push(const ss_contact_query *query, const ss_sample *sample)
{
    const ss_real more = sample->depth - query->stiffening_depth;
    return sample->lean *
           (more > 0 ? sample->depth + (SS_CONTACT_QUERY_STIFFENING - 1) * more : sample->depth);
}

/* kc A_q of a triangle's samples, N/m. */
static inline ss_real ss_contact_query_scale(const ss_contact_query *query, int32_t t)
{
    const ss_grid *grid = &query->surface->grid;
    return (ss_real)(query->stiffness * (double)query->surface->area[t] /
                     (grid->facet_count * grid->part_count));
}

/* ---- friction.c ---- */

void ss_contact_friction_destroy(ss_contact_query *query);
/* mu there; 0 without friction. */
double ss_contact_friction_coefficient(const ss_contact_query *query, int32_t triangle);

/* ---- broad_phase.c ---- */

/* A range of words of the mark bits that may hold set bits. */
typedef struct ss_mark_range {
    int32_t low, high;
} ss_mark_range;

void ss_contact_query_mark(ss_contact_query *query, ss_mark_range *range, int32_t node);
/* Writes the marked nodes in increasing order and clears the marks. */
int32_t ss_contact_query_take_marked(ss_contact_query *query, const ss_mark_range *range,
                                     int32_t *out_node);
/* How far a candidate node has moved since the broad phase; NaN when one is not finite. */
ss_real ss_contact_query_moved(const ss_contact_query *query, const ss_real *u);

static inline void ss_contact_query_frame(const ss_contact_query *query, const ss_tool_pose *pose,
                                          ss_frame *out)
{
    ss_frame_set(out, &query->shape, query->surface->centre, pose);
}

/* ---- inside.c ---- */

/* Does the tool's middle lie inside a closed surface, fitted to `u`? The deepest sample of the last
 * penalty, at `pose`, was `deepest` inside the tool. */
bool ss_contact_query_is_inside(ss_contact_query *query, const ss_real *u, const ss_tool_pose *pose,
                                double deepest);

/* Is the ball about the candidate's triangle further than `distance` from the tool? */
static inline bool ss_candidate_is_beyond(const ss_frame *frame, const ss_candidate *c,
                                          ss_real distance)
{
    const ss_wide r = {c->centre[0] - frame->origin[0], c->centre[1] - frame->origin[1],
                       c->centre[2] - frame->origin[2], 0};
    return ss_frame_is_beyond(frame, &r, c->radius + distance);
}

/* Position of the sample in part `part` of a facet, from a triangle's points. */
static inline void ss_grid_sample(const ss_grid *grid, int32_t facet, int32_t part,
                                  const ss_wide point[SS_GRID_ROW], ss_wide *out)
{
    const uint8_t *f = grid->facet[facet];
    const ss_real *c = grid->part[part];
    *out = c[0] * point[f[0]] + c[1] * point[f[1]] + c[2] * point[f[2]];
}
