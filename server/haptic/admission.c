/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The admission gate: its states, and the share of the force that each lets through. (The force
 * limit is in coupling.c and slip.c.)
 *
 *   SILENT --pose--> WAITING --result for this place--> ENTERING --500 ticks--> IN
 *      ^                ^  \________ not inside _________________________________^ |
 *      |                |                                                          |
 *      +-- no pose, stop +-- pause, fault, reset ------- RAMPING <-- any of them --+
 *
 * A ramp once begun runs its 20 ticks to the end, factor 1 - r/20 in its r-th tick; a pose that
 * returns meanwhile waits and then enters. Ticks that the thread slept through are none: by the
 * clock the force would be gone, or all there, in one step. WAITING gives no force while the proxy
 * follows the pose: the model has not yet said where the tool is. Only results stepped to a target
 * from after the proxy was placed count.
 *
 * Where the tool was placed says whether it was found inside, not when it came to touch: the
 * simulation moved it out of the tissue, or it touches there. Rejected: a touch within 0.1 s that
 * is deeper than the hand's way. Touches by a fast hand right after its first pose were taken for
 * it, since force over static stiffness says more than the depth of a fast one.
 *
 * Entry fades the pose, not the force: with g from 0 to 1 the pose used is x_s + g (x - x_s), x_s
 * the pose moved out along n to the surface, so that the model and the hand sink in together.
 * Fading the force instead would let the model feel the whole depth at once and throw the hand out
 * when the force has grown. No fade is free: a hand that yields with k N/m is pushed out by F/k and
 * given F^2/(2 k), which it paid in the contact before (kidney, 0.5, 1.0 and 1.5 N into grips of
 * 100, 300 and 800 N/m: 1.3, 2.0 and 1.6 mJ, the least 1.2, 1.8 and 1.4). The surface point is
 * smoothed, since the tissue springs back under the first results. A ramp that interrupts an entry
 * keeps the share reached: let in at once, the rest of the depth would throw the hand out before
 * the ramp has taken the force away.
 */
#include "haptic/internal.h"

#include "rt/vec.h"

/* s: a result older than this means that the model no longer answers. */
#define MODEL_TIMEOUT 0.5
/* s: smoothing of the surface while entering. */
#define ENTRY_SMOOTHING 0.02
/* m/s: no faster than this after a surface that gives way, or is another: the tool would be let in.
 */
#define ENTRY_SPEED 0.05

static void begin(ss_admission *admission, ss_phase phase)
{
    admission->phase = phase;
    admission->ticks = 0;
}

double ss_admission_left(const ss_admission *admission)
{
    return admission->phase == SS_PHASE_ENTERING
               ? fmax(0.0, 1.0 - (double)admission->ticks / SS_ENTRY_TICKS)
               : 0.0;
}

/* Is the force to go, or to stay away, whatever the phase? */
static bool is_barred(const ss_admission *admission)
{
    return admission->is_stopped || admission->is_stale || admission->is_paused ||
           admission->is_model_late;
}

static bool place(ss_admission *admission, int64_t tick)
{
    begin(admission, SS_PHASE_WAITING);
    admission->placed = tick;
    return true;
}

bool ss_admission_step(ss_admission *admission, const ss_admission_input *input)
{
    const int64_t tick = input->tick;
    ++admission->ticks;
    const int64_t answered = input->has_result ? input->result_tick : admission->placed;
    admission->is_stopped = admission->is_stopped || input->is_stopping;
    admission->is_stale = tick - input->pose_tick >= SS_WATCHDOG_TICKS;
    admission->is_paused = input->is_paused;
    /* Once late, late until it answers for where the proxy is now. */
    const bool is_overdue = (double)(tick - answered) * input->period > MODEL_TIMEOUT ||
                            (admission->is_model_late && !input->has_result);
    admission->is_model_late =
        !input->is_paused && admission->phase != SS_PHASE_SILENT && (input->is_fault || is_overdue);
    /* The end of a ramp or of the fade. */
    if (admission->phase == SS_PHASE_RAMPING && admission->ticks >= SS_RAMP_TICKS) {
        if (admission->is_stopped || admission->is_stale) {
            begin(admission, SS_PHASE_SILENT);
            return true;
        }
        return place(admission, tick);
    }
    if (admission->phase == SS_PHASE_ENTERING && admission->ticks >= SS_ENTRY_TICKS) {
        begin(admission, SS_PHASE_IN);
    }
    switch (admission->phase) {
    case SS_PHASE_SILENT:
        return !admission->is_stopped && !admission->is_stale && place(admission, tick);
    case SS_PHASE_WAITING:
        if (admission->is_stopped || admission->is_stale) {
            begin(admission, SS_PHASE_SILENT);
            return true;
        }
        return (input->is_reset || input->is_new_holder) && place(admission, tick);
    case SS_PHASE_ENTERING:
    case SS_PHASE_IN:
        if (input->is_new_holder || (input->is_reset && !input->has_force)) {
            return place(admission, tick);
        }
        if (is_barred(admission) || input->is_reset) {
            admission->held_back = ss_admission_left(admission);
            begin(admission, SS_PHASE_RAMPING);
            if (admission->is_stale && !input->is_reset) {
                /* From the tick of silence, though the thread may have slept through it. */
                admission->ticks = tick - (input->pose_tick + SS_WATCHDOG_TICKS);
            }
        }
        return false;
    case SS_PHASE_RAMPING:
        return input->is_new_holder && !admission->is_stopped && place(admission, tick);
    }
    return false;
}

void ss_admission_enter(ss_admission *admission)
{
    begin(admission, SS_PHASE_IN);
}

void ss_admission_fade(ss_admission *admission, int64_t tick, const double point[3],
                       const double normal[3])
{
    begin(admission, SS_PHASE_ENTERING);
    admission->placed = tick;
    ss_copy3(admission->entry_point, point);
    ss_copy3(admission->entry_normal, normal);
}

void ss_admission_follow(ss_admission *admission, double period, const double point[3],
                         const double normal[3])
{
    const double alpha = 1.0 - exp(-period / ENTRY_SMOOTHING);
    double move[3];
    ss_sub3(move, point, admission->entry_point);
    ss_scale3(move, move, alpha);
    const double inward = -ss_dot3(move, admission->entry_normal);
    ss_madd3(move, move, fmax(0.0, inward - ENTRY_SPEED * period), admission->entry_normal);
    ss_add3(admission->entry_point, admission->entry_point, move);
    for (int i = 0; i < 3; ++i) {
        admission->entry_normal[i] += alpha * (normal[i] - admission->entry_normal[i]);
    }
    if (ss_normalize3(admission->entry_normal) == 0.0) {
        ss_copy3(admission->entry_normal, normal);
    }
}

void ss_admission_pose(const ss_admission *admission, double x[3], double v[3])
{
    const double left =
        admission->phase == SS_PHASE_RAMPING ? admission->held_back : ss_admission_left(admission);
    if (!(left > 0.0)) {
        return;
    }
    double inward[3];
    ss_sub3(inward, admission->entry_point, x);
    const double depth = ss_dot3(admission->entry_normal, inward);
    if (depth > 0.0) {
        ss_madd3(x, x, left * depth, admission->entry_normal);
        ss_madd3(v, v, -left * ss_dot3(admission->entry_normal, v), admission->entry_normal);
    }
}

double ss_admission_gain(const ss_admission *admission)
{
    switch (admission->phase) {
    case SS_PHASE_ENTERING:
    case SS_PHASE_IN:
        return 1.0;
    case SS_PHASE_RAMPING:
        return fmax(0.0, 1.0 - (double)(admission->ticks + 1) / SS_RAMP_TICKS);
    case SS_PHASE_SILENT:
    case SS_PHASE_WAITING:
        break;
    }
    return 0.0;
}

int32_t ss_admission_flags(const ss_admission *admission)
{
    int32_t flags = 0;
    if (admission->phase == SS_PHASE_RAMPING || admission->phase == SS_PHASE_ENTERING ||
        is_barred(admission)) {
        flags |= SOFTSIM_FORCE_RAMPING;
    }
    if (admission->is_stale) {
        flags |= SOFTSIM_FORCE_STALE;
    }
    if (admission->is_model_late) {
        flags |= SOFTSIM_FORCE_MODEL_FAULT;
    }
    return flags;
}
