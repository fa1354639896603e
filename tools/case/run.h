/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * One run of a case's body in the product's own world: mesh, supports and load become files and a
 * scene, which goes through the scene loader and is stepped without LCM.
 *
 * Quasi-statics: the load comes over a ramp, and the body is damped until it has settled. Field
 * u_k is read every quarter of 1/omega; c_k = |u_k - u_{k-1}| / |u_k| in the norm of the errors.
 * For a motion that dies out geometrically with q = c_k / c_{k-1} what is left is c_k q / (1 - q)
 * (Aitken); settled is where that has been below 3e-4 for 2/omega, longer than a swing takes to
 * turn. Rejected: a bound on the kinetic energy, which says nothing of a slow, overdamped mode.
 *
 * omega is measured: the body, undamped, under a tenth of its first load at once; omega^2 = <|u -
 * <u>|^2> / <|s - <s>|^2>, s the integral of u - <u> in time: so that the slow motions count, which
 * have to be waited for, and not the many fast ones that a jerk begins (|v|^2 in place of |s|^2
 * puts a plate's at ten times its lowest). It takes until omega t = 14: a body that is still being
 * set in motion has 7.6 whatever it will be. Mass damping of 1.4 omega then is 0.7 of critical.
 * Thread: main of its process.
 */
#include <stdbool.h>
#include <stdint.h>

#include "case/case.h"
#include "case/samples.h"
#include "softsim/softsim.h"

typedef struct ss_static_plan {
    const ss_case *c;
    const ss_case_body *body;
    const char *folder;   /* for the files of the scene; there already */
    const char *model;    /* the lines under `model:`, indented */
    double level;         /* as in the case */
    double omega;         /* 1/s; how fast to load, how often to look */
    double step_s;        /* outer step */
    double longest_cpu_s; /* of the whole run, thread CPU time */
} ss_static_plan;

typedef struct ss_static_run {
    bool is_refused; /* `verdict` says why */
    bool is_good;    /* the fields below mean something: neither refused nor diverged */
    double (*u)[3];  /* m, in the body's order; NULL when refused */
    double force[3]; /* of the tool on the tissue, N; 0 without pushed nodes */
    double p50_us, p99_us, dt_s;
    double to_1pct_ms;     /* thread CPU time until within 1 % of the last field; NaN: never */
    double left;           /* estimate of what has not settled, a fraction */
    softsim_verdict ended; /* of the last step */
    softsim_verdict worst; /* of all; `verdict` in words */
    char verdict[320];
} ss_static_run;

/* The body's own files in the folder: mesh, fixed and pressed nodes. */
softsim_status ss_static_prepare(const ss_case_body *body, const char *folder,
                                 softsim_error *error);
/* What cannot be done is in the run's verdict; an error is a lack of memory or disk, or being
 * stopped. ss_static_run_fini afterwards. */
softsim_status ss_static_execute(const ss_static_plan *plan, ss_static_run *out,
                                 softsim_error *error);
void ss_static_run_fini(ss_static_run *run);
/* The frequency above, for a plan whose model has no damping; NaN where nothing moves. */
softsim_status ss_static_measure(const ss_static_plan *plan, double *out_omega,
                                 softsim_error *error);

/* Gravity from t = 0 on the body at rest, undamped: displacement of `node` after each step. A
 * refusal leaves out_count 0 and its reason in out_verdict. out_u: `count` triples. */
softsim_status ss_static_swing(const ss_static_plan *plan, const double gravity[3], int32_t node,
                               int32_t count, double (*out_u)[3], int32_t *out_count,
                               char out_verdict[320], softsim_error *error);
