/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "correct.h"

#include <math.h>

#include "rt/vec.h"

const ss_corrector_limits ss_corrector_unlimited = {INFINITY, INFINITY};

static const double max_displacement_m = 15e-3;
static const double max_stiffness_n_per_m = 20000.0; /* no server couples harder */
static const int64_t max_age_ns = 50000000;
static const int64_t fade_ns = 20000000, fresh_ns = 10000000;
static const double take_up_s = 0.05, longest_s = 0.01, give_back_s = 0.02;
static const double slip_credit_m = 5e-3;
static const double touch_n = 0.02;
static const double free_debt_j = 0.1e-3, forget_s = 0.4, foreseen_s = 0.005;
static const double most_damping_n_s_per_m = 60.0, damping_by_lag_kg = 0.1, give_back_m = 0.03e-3;
static const double least_cutoff_hz = 20.0, most_cutoff_hz = 100.0, cutoff_hz_per_m_per_s = 2000.0;

void ss_corrector_init(ss_corrector *corrector, bool is_enabled, ss_corrector_limits limits)
{
    *corrector = (ss_corrector){.is_enabled = is_enabled, .limits = limits, .present = 1.0};
}

void ss_corrector_note_pose(ss_corrector *corrector, int32_t seq, int64_t time_ns,
                            const double position[3])
{
    const int32_t slot = seq % SS_CORRECT_HISTORY;
    corrector->history[slot].seq = seq;
    corrector->history[slot].time_ns = time_ns;
    ss_copy3(corrector->history[slot].position, position);
}

void ss_corrector_take_force(ss_corrector *corrector, const softsim_force *force,
                             int64_t receive_ns)
{
    corrector->force = *force;
    corrector->received_ns = receive_ns;
    corrector->has_force = true;
}

/* 1 while forces come, then down to 0. */
static double fade(const ss_corrector *corrector, int64_t now_ns)
{
    const int64_t over_ns = now_ns - corrector->received_ns - max_age_ns;
    return over_ns <= 0 ? 1.0 : fmax(0.0, 1.0 - (double)over_ns / (double)fade_ns);
}

int32_t ss_corrector_force_seq(const ss_corrector *corrector, int64_t now_ns)
{
    return corrector->has_force && fade(corrector, now_ns) > 0.0 ? corrector->force.seq : -1;
}

/* x - x_a, or false when the force is not to be corrected. */
static bool displacement(const ss_corrector *corrector, int64_t now_ns, const double position[3],
                         double out_moved[3])
{
    const softsim_force *force = &corrector->force;
    const int32_t slot = force->pose_seq % SS_CORRECT_HISTORY;
    if (!corrector->is_enabled || force->pose_seq < 1 || !(force->stiffness > 0.0) ||
        corrector->history[slot].seq != force->pose_seq ||
        now_ns - corrector->history[slot].time_ns > max_age_ns) {
        return false;
    }
    ss_sub3(out_moved, position, corrector->history[slot].position);
    return ss_norm3(out_moved) <= max_displacement_m;
}

/* Across the normal: what a normal force holds, at a coefficient of friction of 1, and has `share`
 * of left, and what it does not. */
static void correct_across(double holds_n, double share, double stiffness, const double moved[3],
                           double inout_force[3])
{
    const double size = ss_norm3(inout_force);
    if (!(size > 0.0)) {
        return;
    }
    const double held = fmin(size, holds_n);
    const double given = stiffness * fmax(0.0, ss_dot3(inout_force, moved) / size);
    const double beyond = fmax(0.0, size - held - given);
    ss_scale3(inout_force, inout_force, (held * share + beyond) / size);
}

/* The force at `moved` from where it was answered. */
static void correct(const softsim_force *force, const double moved[3], double out_force[3])
{
    const double stiffness = fmin(force->stiffness, max_stiffness_n_per_m);
    const double *n = force->normal;
    const double normal_force = ss_dot3(n, force->force);
    if ((force->flags & SOFTSIM_FORCE_GRASPING) != 0) {
        ss_madd3(out_force, force->force, -stiffness, moved);
    } else if (fabs(ss_norm3(n) - 1.0) < 1e-3 && normal_force > 0.0) {
        const double corrected = fmax(0.0, normal_force - stiffness * ss_dot3(n, moved));
        ss_madd3(out_force, force->force, -normal_force, n);
        correct_across(normal_force, fmin(1.0, corrected / normal_force), stiffness, moved,
                       out_force);
        ss_madd3(out_force, out_force, corrected, n);
    }
}

/* What a grasp held is corrected otherwise as soon as the grasp has ended: what that changes comes
 * in give_back_s. Not where another holds the probe, which ends at once, nor after a silence, in
 * which all has gone. */
static void soften_end(ss_corrector *corrector, double elapsed_s, double force[3])
{
    const bool is_over = (corrector->force.flags & SOFTSIM_FORCE_OTHER_SENDER) != 0;
    const bool is_grasping = (corrector->force.flags & SOFTSIM_FORCE_GRASPING) != 0;
    if (is_over || corrector->present <= 0.0) {
        ss_set3(corrector->left, 0.0, 0.0, 0.0);
    } else if (corrector->was_grasping && !is_grasping) {
        ss_scale3(corrector->left, corrector->undamped, corrector->present);
        ss_sub3(corrector->left, corrector->left, force);
    }
    corrector->was_grasping = is_grasping;
    ss_scale3(corrector->left, corrector->left, exp(-elapsed_s / give_back_s));
    ss_add3(force, force, corrector->left);
}

/* What the hand did under the force exerted since the last call, `elapsed_s` ago. */
static void note_motion(ss_corrector *corrector, double elapsed_s, const double position[3])
{
    corrector->cutoff_hz = fmin(
        most_cutoff_hz, least_cutoff_hz + cutoff_hz_per_m_per_s * ss_norm3(corrector->velocity));
    const double alpha = 1.0 - exp(-2.0 * SS_PI * corrector->cutoff_hz * elapsed_s);
    double moved[3];
    ss_sub3(moved, position, corrector->exerted_at);
    corrector->energy_j -= ss_dot3(corrector->exerted, moved);
    corrector->energy_j *= corrector->energy_j < 0.0 ? exp(-elapsed_s / forget_s) : 1.0;
    for (int i = 0; i < 3; ++i) {
        corrector->velocity[i] += alpha * (moved[i] / elapsed_s - corrector->velocity[i]);
    }
}

/* Of a contact that the server let the tool in to, what it has stored then is the hand's: of the
 * coupling as soon as the stiffness is told, of a slip at the force limit, where it is not, some.
 */
static void note_entry(ss_corrector *corrector, int64_t now_ns, double size)
{
    const softsim_force *force = &corrector->force;
    const bool was_let_in = corrector->is_let_in;
    corrector->is_let_in =
        (force->flags & SOFTSIM_FORCE_RAMPING) != 0 && now_ns - corrector->received_ns < fresh_ns;
    corrector->is_owed = corrector->is_let_in || (corrector->is_owed && corrector->is_touching);
    if (corrector->is_let_in) {
        corrector->energy_j = 0.0;
    } else if (corrector->is_owed && force->stiffness > 0.0) {
        const double stretch_m = fmin(size / force->stiffness, max_displacement_m);
        corrector->energy_j = 0.5 * size * stretch_m;
        corrector->is_owed = false;
    } else if (corrector->is_owed && was_let_in) {
        corrector->energy_j = size * slip_credit_m;
    }
}

/* J: what a force of `size` that falls by the stiffness told does on a hand that goes on along it.
 */
static double handed_out(const ss_corrector *corrector, double elapsed_s, double size, double speed)
{
    const double ahead_s = fmax(foreseen_s, fmin(elapsed_s, longest_s));
    const double stiffness = fmin(corrector->force.stiffness, max_stiffness_n_per_m);
    const double way = fmin(speed * ahead_s, stiffness > 0.0 ? size / stiffness : INFINITY);
    return way * (size - 0.5 * fmax(0.0, stiffness) * way);
}

/* Takes off a force that moves with the hand what its contact has not taken from the hand;
 * `elapsed_s` after the last time. */
static void damp(ss_corrector *corrector, int64_t now_ns, double elapsed_s, double force[3])
{
    const double size = ss_norm3(force);
    /* A silence ends no contact: what it has taken before stays the hand's. */
    const bool is_touching = ss_norm3(corrector->undamped) > touch_n;
    corrector->energy_j = is_touching && !corrector->is_touching ? 0.0 : corrector->energy_j;
    corrector->is_touching = is_touching;
    note_entry(corrector, now_ns, size);
    if (corrector->is_let_in) {
        corrector->taken = 0.0;
        return;
    }
    double taken = 0.0;
    const double speed = size > touch_n ? ss_dot3(force, corrector->velocity) / size : 0.0;
    if (speed > 0.0) {
        const double given = handed_out(corrector, elapsed_s, size, speed);
        const double allowed = fmax(0.0, corrector->energy_j + free_debt_j);
        const double share = given > allowed ? 1.0 - allowed / given : 0.0;
        const double damping =
            fmin(most_damping_n_s_per_m, damping_by_lag_kg * 2.0 * SS_PI * corrector->cutoff_hz);
        taken = fmin(share, damping * speed / size);
    }
    const double rate = 1.0 / give_back_s + fmax(0.0, -speed) / give_back_m;
    corrector->taken = fmax(taken, corrector->taken * exp(-elapsed_s * rate));
    ss_scale3(force, force, 1.0 - corrector->taken);
}

void ss_corrector_force(ss_corrector *corrector, int64_t now_ns, const double position[3],
                        double out_force[3])
{
    ss_set3(out_force, 0.0, 0.0, 0.0);
    if (!corrector->has_force) {
        return;
    }
    const double elapsed_s =
        corrector->has_exerted ? fmax(0.0, 1e-9 * (double)(now_ns - corrector->exerted_ns)) : 0.0;
    const double paced_s = fmin(elapsed_s, longest_s);
    double moved[3];
    ss_copy3(out_force, corrector->force.force);
    if (displacement(corrector, now_ns, position, moved)) {
        correct(&corrector->force, moved, out_force);
    }
    if (corrector->is_enabled) {
        soften_end(corrector, elapsed_s, out_force);
        (void)ss_clamp_norm3(out_force,
                             fmax(ss_norm3(corrector->force.force), corrector->limits.force_n));
    }
    if (paced_s > 0.0 && (corrector->force.flags & SOFTSIM_FORCE_OTHER_SENDER) == 0) {
        (void)ss_clamp_change3(out_force, corrector->undamped,
                               corrector->limits.slew_n_per_s * paced_s);
    }
    ss_copy3(corrector->undamped, out_force);
    corrector->present = fmin(fade(corrector, now_ns), corrector->present + paced_s / take_up_s);
    ss_scale3(out_force, out_force, corrector->present);
    if (corrector->is_enabled && elapsed_s > 0.0) {
        note_motion(corrector, elapsed_s, position);
        damp(corrector, now_ns, elapsed_s, out_force);
    }
    corrector->has_exerted = true;
    corrector->exerted_ns = now_ns;
    ss_copy3(corrector->exerted, out_force);
    ss_copy3(corrector->exerted_at, position);
}

void ss_corrector_withhold(ss_corrector *corrector, double share)
{
    ss_scale3(corrector->exerted, corrector->exerted, 1.0 - share);
    if (share >= 1.0) {
        ss_set3(corrector->undamped, 0.0, 0.0, 0.0);
    }
}
