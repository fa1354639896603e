/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A way over a body at rest on which a tool slides, and what the force on it says.
 *
 * Way: through the place (path.h), as the body bends, in the plane of its normal and a direction
 * in its surface: 50 mm, or less where the surface ends, turns by more than 45 degrees, or is held.
 * The tool's origin keeps its depth, that of the slide in path.h. Mesh points and normals give it
 * corners at every edge, so it is a polynomial of arc length through them that has no waves shorter
 * than 2.5 edges: what the force has of these is not the path's.
 *
 * Figures, over the middle 0.8 of the way, where the speed is even; shares of the mean force:
 *   step    largest change from one millisecond to the next: the body's own shape, at that speed
 *   jump    the same, less the mean change of the 5 ms before and after
 *   ripple  sqrt 2 times the rms of what such a polynomial leaves of the force: the amplitude of a
 *           wave at the mesh's scale
 *   tilt    largest angle between the force and that polynomial's, radians
 *   loop    largest difference of forward and back at the same place
 * Thread: any; set-up only.
 */
#include "bench/felt/path.h"

enum { SS_WAY_POINTS = 401, SS_WAY_DIRECTIONS = 3 };

typedef struct ss_way {
    double length_m;                /* of the tool's origin */
    double edge_m;                  /* mean edge of the triangles near it, at rest */
    double normal[3];               /* at its beginning */
    double point[SS_WAY_POINTS][3]; /* of the tool's origin, evenly spread */
} ss_way;

/* `direction`: 0 is the place's `along`, the next are turned by 60 degrees each. False where memory
 * is short or the body reaches no further than 2 mm. */
bool ss_way_find(const ss_scene *scene, const ss_felt_place *place, int32_t direction, ss_way *out);
/* The tool's origin after `way_m` of the length. */
void ss_way_at(const ss_way *way, double way_m, double out_position[3]);

/* The highest degree whose waves are no shorter than 2.5 edges. */
int32_t ss_way_degree(double length_m, double edge_m, int32_t most);
/* The polynomial of `degree` in at[] that is nearest to value[]. False: out of memory. */
bool ss_way_fit(int32_t count, const double *at, int32_t degree, const double (*value)[3],
                double (*out)[3]);

/* The forces of a slide, a thousand times a second, at even speed. */
typedef struct ss_way_pass {
    int32_t count;
    const double *way_m; /* increasing, or decreasing */
    const double (*force)[3];
} ss_way_pass;

typedef struct ss_way_figures {
    double mean_n, step, jump, ripple, tilt, loop; /* NAN where nothing touches */
} ss_way_figures;

/* The force at `way_m`, between the milliseconds. */
void ss_way_force(const ss_way_pass *pass, double way_m, double out[3]);
/* False: out of memory. */
bool ss_way_judge(const ss_way_pass *forward, const ss_way_pass *back, double edge_m,
                  ss_way_figures *out);
