/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The experiment behind a curve, on a scene's own model: press at constant speed along the inward
 * normal, then hold.
 *
 * The place is the free surface node nearest to a given point, which is on the surface to within a
 * mean edge (one further off, or among fixed nodes, is refused); else one that is far from all
 * fixed nodes, central, and not on an edge; the direction is into the tissue along that node's
 * normal. A scene with a tool is pressed by it (its lowest probe), its +z pointing into the tissue,
 * its origin on the normal through the node; depth 0 is where it just touches the model's surface
 * at rest. A scene without tools is pressed by a patch, all free surface nodes within two mean
 * edges of the node, which moves as one. Depth is the travel of the tool or patch, force its
 * reaction along the normal, positive out of the tissue. The press takes `press_s` seconds to
 * `depth`; time counts from its end.
 *
 * The model is stepped as the world would step it, but the tool is placed and not felt: no
 * coupling, no force limit, no lag stands between depth and force. Going through poses was rejected
 * for that. Thread: one at a time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "curve.h"
#include "softsim/types.h"

/* Everything is borrowed. */
typedef struct ss_press_scene {
    const char *path;
    const char *const *set; /* PATH=VALUE */
    int32_t set_count;
} ss_press_scene;

typedef struct ss_press {
    int32_t probe;              /* -1: a patch */
    double point[3], normal[3]; /* m, world; out of the tissue */
    double orientation[4];      /* of the tool */
    double touch;               /* m, of the tool's origin from the point when it touches */
    int32_t patch_count;        /* nodes */
    char *patch;                /* "prescribed=[...]" for the patch; NULL */
    double depth, press_s;      /* m, s: of the press */
    double limit;               /* m: the tissue ends there */
    double edge, tool_radius;   /* m: the surface's mean edge, the tool's inradius (patch: 0) */
    double contact;             /* m: its radius at the depth by Hertz, a^2 = R d, or the patch's */
    bool is_stiff;              /* by the model's tetrahedra, which are linear */
} ss_press;

/* Finds place and direction (`at` NULL: chosen) on the scene as it is, and whether the depth can be
 * reached. */
softsim_status ss_press_plan(const ss_press_scene *scene, const double *at, double depth,
                             double press_s, ss_press *out, softsim_error *error);
void ss_press_fini(ss_press *press);

/* How a run went. */
typedef struct ss_press_run {
    softsim_verdict verdict; /* the worst */
    const char *reason;      /* static text */
    double sunk;             /* m: the deepest that the contact's own softness let the tool in */
} ss_press_run;

/* The force at every point of the curve. Fails where the scene or the model fails, with the reason
 * in `error`. */
softsim_status ss_press_measure(const ss_press *press, const ss_press_scene *scene,
                                const ss_curve *curve, double *out_force, ss_press_run *out_run,
                                softsim_error *error);
