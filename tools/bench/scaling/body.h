/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The body of the scaling report at a given number of points: an ellipsoid of 100 x 60 x 60 mm
 * (made by softsim-mesh), its scenes (a sphere that slides over it; one loaded node; a poke; a
 * pull) and the sphere's path, as files in a temporary folder; and the runs, headless, one thread.
 *
 * Path, 1 kHz: the sphere stands free over the top, presses d = 6 mm along the normal, waits,
 * slides 30 mm along the meridian at v = 50 mm/s keeping d, waits, leaves, and the body comes to
 * rest. On the undeformed ellipsoid p(t) = (a sin t, 0, c cos t), |dp/dt| = sqrt(a^2 cos^2 t + c^2
 * sin^2 t), and the sphere's centre is p + (R - d) n.
 *
 * The local poke is on a larger body of the same resolution, scaled by sqrt(points / 1192) so that
 * edges are 4 mm long: 0.1 N on the nodes within 10 mm of the top, 3 to 5 mm deep. The pull is 0.5
 * N upwards: pressed in, a round surface shortens at first, eps < 0, and the network answers by its
 * pretension alone; pulled out, it stretches, and the modulus acts.
 *
 * The error of a field u is max |u - u_direct| / max |u_direct| over all nodes. u_direct is the
 * equilibrium of the same body under the same load by the direct solves of core/static_cnn.h, in
 * double, both network and shape; it shares nothing with the model but the scene and its mesh.
 * Under the sphere, which by then stands still, the same load means: the source's weights are those
 * of the touched cells, its share a is 1 (the sphere is pressed in), and the touched nodes with
 * their neighbours, on which the contact acts, stay where the model has them. So the error holds
 * what single precision, the steps, the active set and what has not come to rest yet make of the
 * field, and is blind to the contact's own forces. Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "case/samples.h"
#include "case/scratch.h"
#include "softsim/types.h"

typedef struct ss_body {
    char folder[SS_SCRATCH_PATH]; /* temporary */
    char bin[4096];               /* where softsim-mesh is */
    int32_t points;
    int32_t top_node;   /* at rest; -1: not yet known */
    int32_t node_count; /* with `rest`, m, before scaling; known with top_node */
    double (*rest)[3];
    int32_t triangle_count; /* known with top_node */
    int32_t (*triangle)[3];
    double slide_begin_s, slide_end_s; /* of constant speed */
    double leave_s;                    /* the sphere has stood still for a while */
} ss_body;

typedef struct ss_body_run {
    int32_t nodes;
    ss_samples tick_us;   /* thread CPU time of whole ticks while sliding, or loaded */
    double step_us;       /* p50 of the model's step alone, as the server would publish it */
    double jump;          /* largest change between two forces over the mean while sliding; NaN */
    double mean_force;    /* N while sliding; NaN */
    double balance;       /* (stored + dissipated - work) over the largest stored energy */
    double substeps;      /* mean of a measured step */
    int32_t active_nodes; /* at the end */
    double (*displacement)[3]; /* m: at the end of a load or poke, before the sphere leaves; NULL */
    double direct_error;       /* of `displacement` against a direct solve, as above; NaN */
    softsim_verdict worst;
    char reason[160];        /* of the worst verdict, or why the scene was refused */
    char direct_reason[160]; /* why there is no direct solution; empty: there is, or no field */
    bool is_refused;
} ss_body_run;

/* Makes the temporary folder and the path. */
softsim_status ss_body_open(ss_body *body, softsim_error *error);
/* Removes it. */
void ss_body_close(ss_body *body);
/* Makes the mesh of `points` points. */
softsim_status ss_body_make(ss_body *body, int32_t points, softsim_error *error);
/* A run; ss_body_run_fini afterwards. A scene that is refused is a result, not an error; what
 * is one: files, memory, and being stopped. */
softsim_status ss_body_slide(ss_body *body, ss_body_run *out_run, softsim_error *error);
softsim_status ss_body_load(ss_body *body, ss_body_run *out_run, softsim_error *error);
/* After ss_body_load; `is_whole`: no node is left out of a step. */
softsim_status ss_body_poke(const ss_body *body, bool is_whole, ss_body_run *out_run,
                            softsim_error *error);
/* No node is left out; after ss_body_load. */
softsim_status ss_body_pull(const ss_body *body, ss_body_run *out_run, softsim_error *error);
/* The largest distance of two fields over the largest displacement of `b`; NaN without them. */
double ss_body_apart(const ss_body_run *a, const ss_body_run *b);
void ss_body_run_fini(ss_body_run *run);
