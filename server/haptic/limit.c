/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * When the hand may feel anything at all, and how much.
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
 * when the force has grown. The surface point is smoothed, since the tissue springs back under
 * the first results. A ramp that interrupts an entry keeps the share reached: let in at once, the
 * rest of the depth would throw the hand out before the ramp has taken the force away.
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

static void begin(ss_admission *gate, ss_phase phase)
{
    gate->phase = phase;
    gate->ticks = 0;
}

double ss_admission_left(const ss_admission *gate)
{
    return gate->phase == SS_PHASE_ENTERING ? fmax(0.0, 1.0 - (double)gate->ticks / SS_ENTRY_TICKS)
                                            : 0.0;
}

/* Is the force to go, or to stay away, whatever the phase? */
static bool is_barred(const ss_admission *gate)
{
    return gate->is_stopped || gate->is_stale || gate->is_paused || gate->is_model_late;
}

static bool place(ss_admission *gate, int64_t tick)
{
    begin(gate, SS_PHASE_WAITING);
    gate->placed = tick;
    return true;
}

bool ss_admission_step(ss_admission *gate, const ss_admission_input *input)
{
    const int64_t tick = input->tick;
    ++gate->ticks;
    const int64_t answered = input->has_result ? input->result_tick : gate->placed;
    gate->is_stopped = gate->is_stopped || input->is_stopping;
    gate->is_stale = tick - input->pose_tick >= SS_WATCHDOG_TICKS;
    gate->is_paused = input->is_paused;
    /* Once late, late until it answers for where the proxy is now. */
    const bool is_overdue = (double)(tick - answered) * input->period > MODEL_TIMEOUT ||
                            (gate->is_model_late && !input->has_result);
    gate->is_model_late =
        !input->is_paused && gate->phase != SS_PHASE_SILENT && (input->is_fault || is_overdue);
    /* The end of a ramp or of the fade. */
    if (gate->phase == SS_PHASE_RAMPING && gate->ticks >= SS_RAMP_TICKS) {
        if (gate->is_stopped || gate->is_stale) {
            begin(gate, SS_PHASE_SILENT);
            return true;
        }
        return place(gate, tick);
    }
    if (gate->phase == SS_PHASE_ENTERING && gate->ticks >= SS_ENTRY_TICKS) {
        begin(gate, SS_PHASE_IN);
    }
    switch (gate->phase) {
    case SS_PHASE_SILENT:
        return !gate->is_stopped && !gate->is_stale && place(gate, tick);
    case SS_PHASE_WAITING:
        if (gate->is_stopped || gate->is_stale) {
            begin(gate, SS_PHASE_SILENT);
            return true;
        }
        return (input->is_reset || input->is_new_holder) && place(gate, tick);
    case SS_PHASE_ENTERING:
    case SS_PHASE_IN:
        if (input->is_new_holder || (input->is_reset && !input->has_force)) {
            return place(gate, tick);
        }
        if (is_barred(gate) || input->is_reset) {
            gate->held_back = ss_admission_left(gate);
            begin(gate, SS_PHASE_RAMPING);
            if (gate->is_stale && !input->is_reset) {
                /* From the tick of silence, though the thread may have slept through it. */
                gate->ticks = tick - (input->pose_tick + SS_WATCHDOG_TICKS);
            }
        }
        return false;
    case SS_PHASE_RAMPING:
        return input->is_new_holder && !gate->is_stopped && place(gate, tick);
    }
    return false;
}

void ss_admission_enter(ss_admission *gate)
{
    begin(gate, SS_PHASE_IN);
}

void ss_admission_fade(ss_admission *gate, int64_t tick, const double point[3],
                       const double normal[3])
{
    begin(gate, SS_PHASE_ENTERING);
    gate->placed = tick;
    ss_copy3(gate->entry_point, point);
    ss_copy3(gate->entry_normal, normal);
}

void ss_admission_follow(ss_admission *gate, double period, const double point[3],
                         const double normal[3])
{
    const double share = 1.0 - exp(-period / ENTRY_SMOOTHING);
    double move[3];
    ss_sub3(move, point, gate->entry_point);
    ss_scale3(move, move, share);
    const double inward = -ss_dot3(move, gate->entry_normal);
    ss_madd3(move, move, fmax(0.0, inward - ENTRY_SPEED * period), gate->entry_normal);
    ss_add3(gate->entry_point, gate->entry_point, move);
    for (int i = 0; i < 3; ++i) {
        gate->entry_normal[i] += share * (normal[i] - gate->entry_normal[i]);
    }
    if (ss_normalize3(gate->entry_normal) == 0.0) {
        ss_copy3(gate->entry_normal, normal);
    }
}

void ss_admission_pose(const ss_admission *gate, double x[3], double v[3])
{
    const double left = gate->phase == SS_PHASE_RAMPING ? gate->held_back : ss_admission_left(gate);
    if (!(left > 0.0)) {
        return;
    }
    double inward[3];
    ss_sub3(inward, gate->entry_point, x);
    const double depth = ss_dot3(gate->entry_normal, inward);
    if (depth > 0.0) {
        ss_madd3(x, x, left * depth, gate->entry_normal);
        ss_madd3(v, v, -left * ss_dot3(gate->entry_normal, v), gate->entry_normal);
    }
}

double ss_admission_gain(const ss_admission *gate)
{
    switch (gate->phase) {
    case SS_PHASE_ENTERING:
    case SS_PHASE_IN:
        return 1.0;
    case SS_PHASE_RAMPING:
        return fmax(0.0, 1.0 - (double)(gate->ticks + 1) / SS_RAMP_TICKS);
    case SS_PHASE_SILENT:
    case SS_PHASE_WAITING:
        break;
    }
    return 0.0;
}

int32_t ss_admission_flags(const ss_admission *gate)
{
    int32_t flags = 0;
    if (gate->phase == SS_PHASE_RAMPING || gate->phase == SS_PHASE_ENTERING || is_barred(gate)) {
        flags |= SOFTSIM_FORCE_RAMPING;
    }
    if (gate->is_stale) {
        flags |= SOFTSIM_FORCE_STALE;
    }
    if (gate->is_model_late) {
        flags |= SOFTSIM_FORCE_MODEL_FAULT;
    }
    return flags;
}

bool ss_limit_force(double force[3], double limit)
{
    const double size = ss_norm3(force);
    if (size <= limit) {
        return false;
    }
    ss_scale3(force, force, limit / size);
    return true;
}

bool ss_limit_slew(double force[3], const double last[3], double step)
{
    double change[3];
    ss_sub3(change, force, last);
    if (!ss_limit_force(change, step)) {
        return false;
    }
    ss_add3(force, last, change);
    return true;
}
