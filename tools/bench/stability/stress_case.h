/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * One run of the stability report: a scene of the specimen written as a user would, run headless
 * through the product's own loader, checks, model and haptic tick, and audited from outside.
 *
 * Times scale with the body: tau, the slowest decay of its motion, is proportional to
 * 1 / sqrt(stiffness), and no less than a time of the model's own; loads are ramped in 2 tau, held
 * to 4 tau, released, and the body is watched to 10 tau, in at most SS_STRESS_CASE_MAX_TICKS ticks.
 * The damping is about critical, so that what recovers has recovered by then.
 *
 * A start cannot be set. A tangled one is reached in one step: random forces on half of the
 * surface's nodes from the first step on, released at 4 tau; or random prescribed places for them.
 * A flattened one: a force on the top, or the top prescribed to a share of the height (below 0:
 * through the bottom), also in one step.
 * Thread: main, or a process of its own.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

typedef enum ss_stress_case_kind {
    SS_STRESS_CASE_CONTROL,   /* what must be stable. variant 0: load, 1: probe, 2: prescribed */
    SS_STRESS_CASE_STEP,      /* value: the step over the computed limit */
    SS_STRESS_CASE_SUBSTEP,   /* the same with one sub-step allowed */
    SS_STRESS_CASE_STIFFNESS, /* value: Pa, steps of 1 ms. variant 0: load, 1: probe */
    SS_STRESS_CASE_POISSON,   /* value: Poisson's ratio */
    SS_STRESS_CASE_MASS,      /* value: density of half the body over the other's */
    SS_STRESS_CASE_SLIVER,    /* value: height of two elements over their regular one */
    SS_STRESS_CASE_TELEPORT,  /* value: body sizes a tick. variant 0: probe, 1: the same with the
                           largest jump allowed, 2: the top prescribed */
    SS_STRESS_CASE_FORCE,     /* value: N on one node */
    SS_STRESS_CASE_TANGLED,   /* value: of E h^2 or of h. variant: 0..2 forces, 3..5 places */
    SS_STRESS_CASE_FLATTENED, /* variant 0: force of value E L^2, 1: the top to value times L */
    SS_STRESS_CASE_PROBE,     /* value: m/s */
    SS_STRESS_CASE_CONTRADICTION, /* variant: which */
    SS_STRESS_CASE_NOISE,         /* value: m, either way, on each axis of every pose of a press */
    SS_STRESS_CASE_IN_OUT,        /* value: Hz, out of a press and in again */
    SS_STRESS_CASE_THROUGH, /* value: m/s. variant 0: through the body and back, 1: the same with
                         the largest jump allowed, 2: from side to side */
    SS_STRESS_CASE_SPIN,    /* value: turns a second. variant 0: upright, 1: end over end */
    SS_STRESS_CASE_PAUSE,   /* value: commands a second, pause and resume in turn */
    SS_STRESS_CASE_KINDS
} ss_stress_case_kind;
enum { SS_STRESS_CASE_CONTRADICTIONS = 11, SS_STRESS_CASE_MAX_TICKS = 4000 };

typedef struct ss_stress_case {
    int32_t subject;
    ss_stress_case_kind kind;
    double stiffness_pa;
    double value;
    int32_t variant;
} ss_stress_case;

typedef enum ss_stress_case_outcome {
    SS_STRESS_CASE_STABLE,
    SS_STRESS_CASE_GUARDED,
    SS_STRESS_CASE_REFUSED,
    SS_STRESS_CASE_DIVERGED,
    SS_STRESS_CASE_OUTCOMES
} ss_stress_case_outcome;

typedef struct ss_stress_case_result {
    ss_stress_case_outcome outcome;
    softsim_verdict verdict; /* the program's worst */
    char acted[160];         /* what acted, or why it was refused; "" */
    uint32_t found;          /* by the audit */
    bool is_agreed;
    double limit_s; /* computed; NaN unless asked for */
    double step_s;  /* requested */
    int32_t ticks;
    double substeps;                       /* mean */
    double stored_j, end_j;                /* the largest, and at the end, beyond rest */
    double balance, work_error;            /* shares, NaN */
    double displacement_m;                 /* the largest */
    double kinetic_j;                      /* the largest */
    double handed_out_j, made_j, driven_j; /* to the hand, the most in one contact; hand.h */
    double force_n, depth_m;               /* the largest, of the probe */
    double recovery;                       /* share of it that is left, NaN */
    int32_t inverted;                      /* tetrahedra at the end */
    double cpu_ms;
} ss_stress_case_result;

/* A model with its material, as the report lists it. */
const char *ss_stress_case_subject_name(int32_t subject);
const char *ss_stress_case_subject_model(int32_t subject);
/* Those that are built in; numbers 0.. */
int32_t ss_stress_case_subject_count(void);
/* Does it live on the surface alone? */
bool ss_stress_case_is_surface(int32_t subject);
/* Does it keep the shape that it was given? */
bool ss_stress_case_is_plastic(int32_t subject);
/* Does it book what it does by itself as work, so that F.du is not all of it? */
bool ss_stress_case_has_own_work(int32_t subject);
/* The least tau, s: of a time that no stiffness shortens; 0: there is none. */
double ss_stress_case_own_time(int32_t subject);
/* Does the model have what the kind varies? */
bool ss_stress_case_applies(int32_t subject, ss_stress_case_kind kind);

const char *ss_stress_case_kind_name(ss_stress_case_kind kind);
const char *ss_stress_case_value_name(ss_stress_case_kind kind);
const char *ss_stress_case_outcome_name(ss_stress_case_outcome outcome);

/* Its files lie in a folder of its own in `parent`, and go with it. A scene that is refused is a
 * result; what is an error: files and memory. */
softsim_status ss_stress_case_run(const ss_stress_case *trial, const char *parent,
                                  ss_stress_case_result *out, softsim_error *error);
