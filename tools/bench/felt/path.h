/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Where a hand would press a body, and how its tool moves there.
 *
 * Place: the ray from the middle of the fixed nodes (of the lowest ones, where none is fixed)
 * through the middle of the body leaves the surface at the side away from what holds it; upwards,
 * where the body is held all round. Around that point the surface's normal is averaged over the
 * tool's size. The tool's axis z points against it, into the tissue.
 *
 * Paths: the tool's depth s along that normal (0: it just touches the body at rest), and a way t
 * along the surface. D: the depth, 6 mm or 15 % of the body's least extent if that is less.
 *
 * After 0.2 s of rest:
 *   press     -3 mm to D in (D + 3 mm) / 10 mm/s, held for 0.4 s, back
 *   poke.1    -1 mm to D and back five times, at most 0.1 m/s; poke.3: 0.3 m/s
 *   tap       4.8 times a second, 14.5 mm sin: 0.3 m/s where it touches, 50 ms inside, 3.9 mm deep
 *   slide     at D/2: 20 mm, or a quarter of the body's largest extent, at 50 mm/s and back
 * Thread: any; no memory is kept.
 */
#include "contact/contact.h"
#include "scene/scene.h"

typedef enum ss_felt_path {
    SS_FELT_PRESS,
    SS_FELT_POKE_1,
    SS_FELT_POKE_3,
    SS_FELT_TAP,
    SS_FELT_SLIDE,
    SS_FELT_PATHS
} ss_felt_path;

typedef struct ss_felt_place {
    int32_t probe;
    double point[3], normal[3]; /* on the surface at rest; out of the tissue */
    double along[3];            /* unit, in the surface: the way of a slide */
    double orientation[4];      /* tool to world */
    double reach_m;             /* from the tool's origin to where it touches */
    double depth_m, slide_m;
    double radius_m; /* of the tool where it touches, its curvature's or its inscribed ball's */
    double working_force_n; /* of the scene */
} ss_felt_place;

const char *ss_felt_path_name(ss_felt_path path);
/* False where the scene has no tool, or the ray meets no surface. */
bool ss_felt_find_place(const ss_scene *scene, ss_felt_place *out);
/* How long it lasts, s; of a press the time at which it begins to go back in *out_hold_end_s. */
double ss_felt_path_seconds(const ss_felt_place *place, ss_felt_path path, double *out_hold_end_s);
/* The last contact of a poke or tap: when its way begins and how long it takes, s. */
void ss_felt_path_last(const ss_felt_place *place, ss_felt_path path, double *out_from_s,
                       double *out_seconds);
/* The tool's origin `depth_m` deep on the way of a press. */
void ss_felt_path_deep(const ss_felt_place *place, double depth_m, double out_position[3]);
/* The tool's origin at that time. A press that is held for longer does not go back: `is_held`. */
void ss_felt_path_at(const ss_felt_place *place, ss_felt_path path, bool is_held, double time_s,
                     double out_position[3]);
