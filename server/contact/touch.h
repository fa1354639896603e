/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Where a hand that comes from one side first meets a body at rest: for who starts one (the
 * bridge), and for who says where (--check, softsim-mesh scene). touch.c has the rule. SI, world
 * frame. Thread: set-up only; memory is the caller's.
 */
#include <stdbool.h>
#include <stdint.h>

#include "contact/contact.h"

/* The sides that a hand may come from, and the --axes of a bridge whose device has its z there. */
enum { SS_TOUCH_SIDES = 6 };
typedef struct ss_touch_side {
    const char *name; /* "+z" */
    double towards[3];
    const char *axes;
} ss_touch_side;
extern const ss_touch_side ss_touch_sides[SS_TOUCH_SIDES]; /* the usual one first */

/* A surface, of a mesh or as the mesh messages tell it. */
typedef struct ss_touch_body {
    int32_t node_count, triangle_count;
    const double (*position)[3];
    const int32_t (*triangle)[3]; /* counter-clockwise from outside */
    const uint8_t *fixed;         /* of each node: not 0, it is held */
} ss_touch_body;

/* The end of a tool that comes first, turned about the tool's axis. */
typedef struct ss_touch_end {
    double radius; /* m, > 0 */
    double below;  /* m: from the tool's origin to the end's flat, or to the centre of its ball */
    bool is_round; /* a ball of that radius */
} ss_touch_end;
/* Of a tool that comes with its -z ahead, as those of a device that is not turned do. A box or a
 * convex mesh counts as the cylinder around it. */
ss_touch_end ss_touch_end_of(const ss_shape *shape);

typedef struct ss_touch {
    double point[3], normal[3]; /* on the surface; out of it */
    double origin[3];           /* of the tool when it just touches */
} ss_touch;

/* The place to press for a hand that comes from `towards` (unit, out of the tissue). False: there
 * is none, since all that can be reached from there is held or steep; or out of memory. */
bool ss_touch_find(const ss_touch_body *body, const double towards[3], const ss_touch_end *end,
                   ss_touch *out);

/* Distance (m) from x to the surface, and the point there; INFINITY without triangles. */
double ss_touch_distance(const ss_touch_body *body, const double x[3], double out_nearest[3]);
