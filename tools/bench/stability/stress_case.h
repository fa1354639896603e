/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * One run of the stability report: a scene of the specimen written as a user would, run headless
 * through the product's own loader, checks, model and haptic tick, and audited from outside.
 *
 * Times scale with the body: tau, the slowest decay of its motion, is proportional to
 * 1 / sqrt(stiffness); loads are ramped in 2 tau, held to 4 tau, released, and the body is watched
 * to 10 tau, in at most SS_ASSAY_MAX_TICKS ticks. The damping is about critical, so that what
 * recovers has recovered by then.
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

typedef enum ss_assay_kind {
    SS_ASSAY_CONTROL,       /* what must be stable. variant 0: load, 1: probe, 2: prescribed */
    SS_ASSAY_STEP,          /* value: the step over the computed limit */
    SS_ASSAY_SUBSTEP,       /* the same with one sub-step allowed */
    SS_ASSAY_STIFFNESS,     /* value: Pa, steps of 1 ms. variant 0: load, 1: probe */
    SS_ASSAY_POISSON,       /* value: Poisson's ratio */
    SS_ASSAY_MASS,          /* value: density of half the body over the other's */
    SS_ASSAY_SLIVER,        /* value: height of two elements over their regular one */
    SS_ASSAY_TELEPORT,      /* value: body sizes a tick. variant 0: probe, 1: the same with the
                               largest jump allowed, 2: the top prescribed */
    SS_ASSAY_FORCE,         /* value: N on one node */
    SS_ASSAY_TANGLED,       /* value: of E h^2 or of h. variant: 0..2 forces, 3..5 places */
    SS_ASSAY_FLATTENED,     /* variant 0: force of value E L^2, 1: the top to value times L */
    SS_ASSAY_PROBE,         /* value: m/s */
    SS_ASSAY_CONTRADICTION, /* variant: which */
    SS_ASSAY_NOISE,         /* value: m, either way, on each axis of every pose of a press */
    SS_ASSAY_IN_OUT,        /* value: Hz, out of a press and in again */
    SS_ASSAY_THROUGH,       /* value: m/s. variant 0: through the body and back, 1: the same with
                               the largest jump allowed, 2: from side to side */
    SS_ASSAY_SPIN,          /* value: turns a second. variant 0: upright, 1: end over end */
    SS_ASSAY_PAUSE,         /* value: commands a second, pause and resume in turn */
    SS_ASSAY_KINDS
} ss_assay_kind;
enum { SS_ASSAY_CONTRADICTIONS = 11, SS_ASSAY_MAX_TICKS = 4000 };

typedef struct ss_assay {
    int32_t subject;
    ss_assay_kind kind;
    double stiffness_pa;
    double value;
    int32_t variant;
} ss_assay;

typedef enum ss_assay_outcome {
    SS_ASSAY_STABLE,
    SS_ASSAY_GUARDED,
    SS_ASSAY_REFUSED,
    SS_ASSAY_DIVERGED,
    SS_ASSAY_OUTCOMES
} ss_assay_outcome;

typedef struct ss_assay_result {
    ss_assay_outcome outcome;
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
} ss_assay_result;

/* A model with its material, as the report lists it. */
const char *ss_assay_subject_name(int32_t subject);
const char *ss_assay_subject_model(int32_t subject);
/* Those that are built in; numbers 0.. */
int32_t ss_assay_subject_count(void);
/* Does it live on the surface alone? */
bool ss_assay_is_surface(int32_t subject);
/* Does it keep the shape that it was given? */
bool ss_assay_is_plastic(int32_t subject);
/* Does it book what it does by itself as work, so that F.du is not all of it? */
bool ss_assay_has_own_work(int32_t subject);
/* Does the model have what the kind varies? */
bool ss_assay_applies(int32_t subject, ss_assay_kind kind);

const char *ss_assay_kind_name(ss_assay_kind kind);
const char *ss_assay_value_name(ss_assay_kind kind);
const char *ss_assay_outcome_name(ss_assay_outcome outcome);

/* Its files lie in a folder of its own in `parent`, and go with it. A scene that is refused is a
 * result; what is an error: files and memory. */
softsim_status ss_assay_run(const ss_assay *trial, const char *parent, ss_assay_result *out,
                            softsim_error *error);
