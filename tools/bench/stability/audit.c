/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/audit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rt/vec.h"

/* Shares that are let pass: of the largest energy stored or work done, and of the largest
 * displacement. A force of the wrong sign, a factor of two, a lost term are all far beyond. */
static const double energy_share = 0.05;
static const double rest_share = 0.1;
/* Rounding of sums in single precision, of the energy that is in the body at rest. */
static const double rounding = 1e-5;

void ss_audit_begin(ss_audit *audit, const ss_audit_plan *plan)
{
    *audit = (ss_audit){.plan = *plan};
}

/* The largest length of three numbers each; NaN or infinite where any is. */
static double largest_of(const double (*x)[3], int32_t count)
{
    double largest = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        const double length = ss_norm3(x[i]);
        if (!isfinite(length)) {
            return (double)NAN;
        }
        largest = fmax(largest, length);
    }
    return largest;
}

static double floor_of(const ss_audit *audit)
{
    return audit->plan.floor + rounding * fabs(audit->first_stored);
}

static void look_at_energies(ss_audit *audit, const ss_audit_sample *sample)
{
    const double stored = sample->kinetic + sample->elastic;
    const double balance = stored + sample->dissipated - sample->work;
    if (!audit->has_first) {
        audit->has_first = true;
        audit->first = balance;
        audit->first_stored = stored;
        audit->first_work = sample->work;
    }
    audit->largest_stored = fmax(audit->largest_stored, stored - audit->first_stored);
    audit->scale = fmax(audit->scale, fabs(stored - audit->first_stored));
    audit->scale = fmax(audit->scale, fabs(sample->work - audit->first_work));
    audit->gain = fmax(audit->gain, balance - audit->first);
    audit->loss = fmax(audit->loss, audit->first - balance);
    audit->applied += sample->applied;
    audit->worst_work =
        fmax(audit->worst_work, fabs(sample->work - audit->first_work - audit->applied));
    if (sample->is_released) {
        audit->released = audit->was_released ? audit->released : stored;
        audit->worst_growth = fmax(audit->worst_growth, stored - audit->released);
        audit->was_released = true;
    }
}

void ss_audit_look(ss_audit *audit, const ss_audit_sample *sample)
{
    const double far = largest_of(sample->displacement, sample->count);
    const double fast = largest_of(sample->velocity, sample->count);
    const double sum = sample->kinetic + sample->elastic + sample->dissipated + sample->work;
    if (!isfinite(far) || !isfinite(fast) || !isfinite(sum) || !isfinite(ss_norm3(sample->force))) {
        audit->found |= SS_AUDIT_NOT_FINITE;
        return;
    }
    audit->largest = fmax(audit->largest, far);
    audit->last = far;
    audit->found |= far > audit->plan.reach ? SS_AUDIT_FAR : 0u;
    look_at_energies(audit, sample);
}

uint32_t ss_audit_end(ss_audit *audit, bool is_rested)
{
    const double limit = energy_share * audit->scale + floor_of(audit);
    audit->found |= audit->gain > limit ? SS_AUDIT_GAIN : 0u;
    audit->found |= audit->loss > limit ? SS_AUDIT_LOSS : 0u;
    audit->found |= audit->plan.has_work && audit->worst_work > limit ? SS_AUDIT_WORK : 0u;
    audit->found |= audit->worst_growth > limit ? SS_AUDIT_GROWS : 0u;
    audit->found |= is_rested && audit->last > rest_share * audit->largest + audit->plan.still
                        ? SS_AUDIT_NOT_BACK
                        : 0u;
    return audit->found;
}

static double share(const ss_audit *audit, double gap)
{
    return audit->scale > floor_of(audit) ? gap / audit->scale : (double)NAN;
}

double ss_audit_balance_error(const ss_audit *audit)
{
    return share(audit, audit->gain > audit->loss ? audit->gain : -audit->loss);
}

double ss_audit_work_error(const ss_audit *audit)
{
    return audit->plan.has_work ? share(audit, audit->worst_work) : (double)NAN;
}

double ss_audit_recovery_error(const ss_audit *audit)
{
    return audit->was_released && audit->largest > 0.0 ? audit->last / audit->largest : (double)NAN;
}

bool ss_audit_agrees(uint32_t found, softsim_verdict worst)
{
    if ((found & SS_AUDIT_NOT_FINITE) != 0) {
        return false;
    }
    return worst == SOFTSIM_VERDICT_GOOD ? found == 0
           : worst == SOFTSIM_VERDICT_GUARDED
               ? (found & ~(uint32_t)(SS_AUDIT_NOT_BACK | SS_AUDIT_LOSS | SS_AUDIT_HANDED_OUT)) == 0
               : true;
}

void ss_audit_text(uint32_t found, char *out, int32_t size)
{
    static const char *const name[SS_AUDIT_KINDS] = {"not finite",
                                                     "too far",
                                                     "spurious energy",
                                                     "energy lost",
                                                     "work",
                                                     "grows after release",
                                                     "not back",
                                                     "energy handed out",
                                                     "force above the limit",
                                                     "deeper than the body",
                                                     "the hand is driven"};
    out[0] = '\0';
    for (int k = 0; k < SS_AUDIT_KINDS; ++k) {
        if ((found >> k & 1u) != 0) {
            const size_t used = strlen(out);
            snprintf(out + used, (size_t)size - used, "%s%s", used > 0 ? ", " : "", name[k]);
        }
    }
}
