/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * An independent look at what a world publishes, that trusts none of its verdicts: is all of it
 * finite; is no node further away than what is done to the body explains; does the energy add up,
 * and does the work of the loads as published agree with F.du of the published displacements; does
 * nothing gain energy once the body is left alone; is it back at rest when it had the time.
 *
 * A run with a tool adds what the hand got (hand.h): more energy than tissue can give, a force
 * above the limit, a depth beyond the body.
 *
 * Then the two judgements must agree: verdicts `good` and `guarded` promise a result to be trusted,
 * so that any finding is a silent failure; `good` also promises the shape at rest after release,
 * while a guarded one may have been left elsewhere (folded, say), or have handed out energy: what
 * the sampling of a quick hand gives, but not so much that the hand is driven. `degraded` and
 * `fault` declare the result untrusted, but even then nothing that is not finite may be published.
 * Thread: any; nothing here reads a clock.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

/* What was found. */
enum {
    SS_AUDIT_NOT_FINITE = 1,
    SS_AUDIT_FAR = 2,       /* beyond `reach` */
    SS_AUDIT_GAIN = 4,      /* stored + dissipated - work has grown: spurious energy */
    SS_AUDIT_LOSS = 8,      /* it has shrunk */
    SS_AUDIT_WORK = 16,     /* the published work is not F.du */
    SS_AUDIT_GROWS = 32,    /* stored energy grew after release */
    SS_AUDIT_NOT_BACK = 64, /* not at rest again */
    /* What a hand got of it; hand.h. */
    SS_AUDIT_HANDED_OUT = 128, /* energy, in one contact or a part of it */
    SS_AUDIT_FORCE = 256,      /* more than the limit */
    SS_AUDIT_DEPTH = 512,      /* more than the body's size */
    SS_AUDIT_DRIVEN = 1024,    /* ten times as much energy */
    SS_AUDIT_KINDS = 11
};

typedef struct ss_audit_plan {
    double reach;  /* m: the largest displacement that is explained */
    double floor;  /* J: below it energies are rounding */
    double still;  /* m: below it displacements are rounding */
    bool has_work; /* the samples carry the work of all that acts on the body */
} ss_audit_plan;

/* One state of the world. */
typedef struct ss_audit_sample {
    int32_t count; /* nodes */
    const double (*displacement)[3], (*velocity)[3];
    double kinetic, elastic, dissipated, work; /* J, as published */
    double force[3];                           /* N, of the probe, as published */
    double applied;                            /* J: F.du since the sample before */
    bool is_released;                          /* nothing acts on the body since the one before */
} ss_audit_sample;

typedef struct ss_audit {
    ss_audit_plan plan;
    uint32_t found;
    bool has_first, was_released;
    double first;                                /* J: the energy balance at the start */
    double scale;                                /* J: the largest of what was stored and done */
    double gain, loss;                           /* J, the largest, of the energy balance */
    double applied, first_work, worst_work;      /* J */
    double first_stored, released, worst_growth; /* J */
    double largest, last;                        /* m: displacement in all, and now */
    double largest_stored;                       /* J, beyond the start */
} ss_audit;

void ss_audit_begin(ss_audit *audit, const ss_audit_plan *plan);
void ss_audit_look(ss_audit *audit, const ss_audit_sample *sample);
/* After the last look; `is_rested`: released long enough to be back at rest. */
uint32_t ss_audit_end(ss_audit *audit, bool is_rested);

/* As shares: of the energy balance, of the work, of the displacement that is left; NaN where there
 * is nothing to compare. */
double ss_audit_balance_error(const ss_audit *audit);
double ss_audit_work_error(const ss_audit *audit);
double ss_audit_recovery_error(const ss_audit *audit);

/* Does the program's worst verdict agree with what was found? */
bool ss_audit_agrees(uint32_t found, softsim_verdict worst);
/* "not finite, too far", or "" when nothing was found; at least 192 bytes. */
void ss_audit_text(uint32_t found, char *out, int32_t size);
