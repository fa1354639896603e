/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "world/watch.h"

#include <math.h>
#include <string.h>

#include "haptic/haptic.h"
#include "rt/vec.h"

static const double load_share = 0.1;                     /* of what loads did: their error */
static const double pool_time = 0.1;                      /* s */
static const double degraded_at = 10.0, fault_at = 100.0; /* times what is guarded */
static const double most_handed_out = 0.01;               /* J */
static const double most_guarded = 0.1;                   /* J: beyond, degraded */
static const double contact_gap_time = 0.02;              /* s: no hand taps as fast */
static const double tell_time = 1.0;                      /* s */
static const double far_behind = 0.003;                   /* m */
static const double long_behind = 0.02;                   /* s */
static const double shaking_time = 0.5;                   /* s */
static const double most_shaking = 25.0;                  /* times the force limit */
static const double untold_lag = 0.004;                   /* s, the step of the lags */
static const double untold_pass = 6.0, untold_time = 1.0; /* Hz, s */
static const double untold_short = 0.5;                   /* s */
static const double most_untold = 0.03;                   /* J, U */
static const double most_untold_shaken = 0.008;           /* J, V */
static const double most_period = 0.01;                   /* s: the filter's */
static const double silence_time = 0.02;                  /* s: beyond the usual */
static const double usual_share = 0.02;                   /* of a new interval in the usual one */
static const double contact_force = 0.02;                 /* N: less is no contact */

/* ---- tissue ---- */

void ss_energy_watch_step(ss_energy_watch *watch, const ss_model_info *info, double way, double dt)
{
    const double stored = info->kinetic + info->elastic;
    if (!(watch->limit > 0.0) || watch->verdict == SOFTSIM_VERDICT_FAULT) {
        return;
    }
    const double change =
        watch->has_stored ? stored - watch->stored - (info->load_work - watch->load_work) : 0.0;
    watch->stored = stored;
    watch->load_work = info->load_work;
    watch->has_stored = true;
    watch->pool = fmax(0.0, watch->pool * exp(-dt / pool_time) + change - watch->limit * way);
    const double share =
        watch->pool / (watch->limit * watch->size + load_share * fabs(info->load_work));
    watch->verdict = share > fault_at      ? SOFTSIM_VERDICT_FAULT
                     : share > degraded_at ? SOFTSIM_VERDICT_DEGRADED
                     : share > 1.0         ? SOFTSIM_VERDICT_GUARDED
                                           : SOFTSIM_VERDICT_GOOD;
}

void ss_energy_watch_judge(const ss_energy_watch *watch, ss_model_info *info)
{
    if (watch->verdict <= info->verdict) {
        return;
    }
    info->verdict = watch->verdict;
    info->fault_bits |= watch->verdict >= SOFTSIM_VERDICT_DEGRADED ? SS_MODEL_FAULT_ENERGY : 0u;
    info->reason =
        watch->verdict == SOFTSIM_VERDICT_FAULT
            ? "the tissue gained more energy than any tool could supply; the simulation is "
              "stopped until reset"
            : "the tissue took up more energy than a hand at haptic.max_force_n gives: move "
              "slower, or steady the device";
}

void ss_energy_watch_skip(ss_energy_watch *watch)
{
    watch->has_stored = false;
}

void ss_energy_watch_reset(ss_energy_watch *watch)
{
    *watch = (ss_energy_watch){.limit = watch->limit, .size = watch->size};
}

/* ---- hand ---- */

/* The last force is less than 20 ms ago, or an answer of it may still be in effect. */
static bool is_spell_on(const ss_hand_watch *watch, const ss_hand_tick *now)
{
    const int64_t released = now->tick - watch->touched;
    return released <= SS_HAND_WATCH_DELAYS ||
           ((double)released - 0.5) * now->period < contact_gap_time;
}

/* Since the last pose. */
static void move_hand(ss_hand_watch *watch, const softsim_pose *pose, double out_way[3],
                      double out_turn[3])
{
    ss_set3(out_way, 0.0, 0.0, 0.0);
    ss_set3(out_turn, 0.0, 0.0, 0.0);
    if (watch->has_pose) {
        ss_sub3(out_way, pose->position, watch->position);
        ss_turn_between(watch->orientation, pose->orientation, out_turn);
    } else {
        ss_copy3(watch->untold.place_pass.low, pose->position);
    }
    ss_copy3(watch->position, pose->position);
    memcpy(watch->orientation, pose->orientation, sizeof watch->orientation);
    watch->has_pose = true;
}

/* Returns the most that the contact has handed out. */
static double add_up(ss_hand_watch *watch, const double given[SS_HAND_WATCH_DELAYS], bool is_spell)
{
    double most = 0.0;
    for (int d = 0; d < SS_HAND_WATCH_DELAYS; ++d) {
        const bool is_felt = ss_norm3(watch->force[d]) + ss_norm3(watch->torque[d]) > 0.0;
        watch->energy[d] = is_felt ? watch->energy[d] + given[d] : 0.0;
        watch->spell[d] = is_spell ? watch->spell[d] + given[d] : 0.0;
        most = fmax(most, fmax(watch->energy[d], watch->spell[d]));
    }
    return most;
}

static void take_answer(ss_hand_watch *watch, const ss_hand_tick *now)
{
    memmove(watch->force[1], watch->force[0], sizeof watch->force[0]);
    memmove(watch->torque[1], watch->torque[0], sizeof watch->torque[0]);
    ss_copy3(watch->force[0], now->sent->force);
    ss_copy3(watch->torque[0], now->sent->torque);
}

/* Energy given to the hand in a part of the contact that nobody had, as far as results tell. Other
 * hands, loads and the entry explain what they put in; what they take out is not looked at, for
 * what they took the tissue may have had from anyone. */
static double judge_parts(ss_hand_watch *watch, const ss_hand_tick *now,
                          const double given[SS_SUPPLY_DEVICES], bool is_counted)
{
    ss_supply *supply = &watch->supply;
    const ss_simulation_result *result = now->result;
    double made = 0.0;
    double others = fmax(0.0, now->let_in_j) + fmax(0.0, now->others_j - watch->others_j);
    watch->others_j = now->others_j;
    if (result) {
        made = ss_supply_take(supply, result->stored, result->has_stored);
        others += fmax(0.0, result->load_work - watch->load_work);
        watch->load_work = result->load_work;
    }
    if (!is_counted) {
        return fmax(made, ss_supply_clear(supply));
    }
    double slip[3];
    ss_sub3(slip, now->sent->proxy, watch->position);
    ss_supply_tick(supply, given, others, ss_norm3(now->sent->force) * ss_norm3(slip));
    return made;
}

/* Of what a contact has handed out, some of which may have been let in, and what nobody had. */
static ss_hand_verdict judge_hand(double handed_out, double let_in, double made)
{
    const double driven = handed_out - fmax(0.0, let_in);
    if (made > most_handed_out && made > driven) {
        return (ss_hand_verdict){made > most_guarded ? SOFTSIM_VERDICT_DEGRADED
                                                     : SOFTSIM_VERDICT_GUARDED,
                                 "in part of a contact the hand got over 10 mJ that neither it nor "
                                 "the tissue had supplied: it moves or shakes faster than forces "
                                 "can follow; steady it, or lower "
                                 "haptic.coupling.stiffness_n_per_m"};
    }
    if (driven > most_handed_out) {
        return (ss_hand_verdict){
            driven > most_guarded ? SOFTSIM_VERDICT_DEGRADED : SOFTSIM_VERDICT_GUARDED,
            "more than 10 mJ were handed to the hand in one contact: it moves or shakes faster "
            "than forces can follow; steady it, or lower haptic.coupling.stiffness_n_per_m"};
    }
    if (handed_out > most_handed_out) {
        return (ss_hand_verdict){
            SOFTSIM_VERDICT_GUARDED,
            "a tool that was found inside the tissue was let in, and what pressed it out again was "
            "no work of the hand: start, resume and return outside of the tissue"};
    }
    return (ss_hand_verdict){SOFTSIM_VERDICT_GOOD, ""};
}

/* A tool that comes up slowly behind the hand, which feels nothing meanwhile. */
static ss_hand_verdict judge_trail(ss_hand_watch *watch, const ss_hand_tick *now)
{
    const int32_t hidden = SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_STALE | SOFTSIM_FORCE_MODEL_FAULT;
    double behind[3];
    ss_sub3(behind, now->sent->proxy, watch->position);
    const bool is_behind = now->trail_s > SS_LONGEST_TRAIL_S && (now->sent->flags & hidden) == 0 &&
                           !(ss_norm3(now->sent->force) > 0.0) && ss_norm3(behind) > far_behind;
    watch->trailing = is_behind ? watch->trailing + 1 : 0;
    if ((double)watch->trailing * now->period > long_behind) {
        return (ss_hand_verdict){
            SOFTSIM_VERDICT_DEGRADED,
            "the tool comes up late behind the hand, and what it touches is felt late or not at "
            "all: lower haptic.coupling.damping_n_s_per_m, raise its stiffness_n_per_m, or move "
            "slower"};
    }
    return (ss_hand_verdict){SOFTSIM_VERDICT_GOOD, ""};
}

/* A force that goes to and fro as no hand does. */
static ss_hand_verdict judge_shaking(ss_hand_watch *watch, const ss_hand_tick *now)
{
    double change[3];
    ss_sub3(change, now->sent->force, watch->last_force);
    ss_copy3(watch->last_force, now->sent->force);
    watch->shaking *= exp(-now->period / shaking_time);
    watch->shaking += ss_norm3(change);
    if (watch->shaking > most_shaking * now->max_force_n) {
        return (ss_hand_verdict){
            SOFTSIM_VERDICT_GUARDED,
            "the force shakes faster than a hand moves: a device that answers late is to name the "
            "force it exerts (force_seq, applied_force) or to correct it; steady it, or lower "
            "haptic.coupling.stiffness_n_per_m"};
    }
    return (ss_hand_verdict){SOFTSIM_VERDICT_GOOD, ""};
}

/* J: what a device that tells its force, and does not name it, was given beyond what the observer
 * counts, where poses were lost: what they would have told lies between the last and this one. */
static double add_lost(ss_hand_watch *watch, const ss_hand_tick *now, const double way[3],
                       bool is_counted)
{
    const softsim_pose *pose = now->pose;
    watch->lost_j = is_counted ? watch->lost_j : 0.0;
    if (pose == NULL) {
        return watch->lost_j;
    }
    const bool is_alone = pose->force_seq < 0 && ss_is_finite(pose->applied_force, 3);
    const double gap = (double)pose->seq - (double)watch->seq - (double)now->superseded;
    if (is_alone && watch->is_alone && gap > 1.0) {
        double change[3];
        ss_sub3(change, watch->applied, pose->applied_force);
        watch->lost_j += 0.5 * (gap - 1.0) / gap * ss_dot3(change, way);
    }
    watch->is_alone = is_alone;
    watch->seq = pose->seq;
    ss_copy3(watch->applied, pose->applied_force);
    return watch->lost_j;
}

static bool is_touched(const softsim_force *sent)
{
    return ss_norm3(sent->force) + ss_norm3(sent->torque) > 0.0;
}

/* Second order, as a state-variable filter. */
static void pass_high(ss_high_pass *pass, const double in[3], double period, double out[3])
{
    const double g = tan(SS_PI * untold_pass * fmin(period, most_period));
    for (int a = 0; a < 3; ++a) {
        out[a] =
            (in[a] - (sqrt(2.0) + g) * pass->band[a] - pass->low[a]) / (1.0 + g * (sqrt(2.0) + g));
        const double band = pass->band[a] + g * out[a];
        pass->band[a] = band + g * out[a];
        pass->low[a] += 2.0 * g * band;
    }
}

/* The force of this tick, for later ones, and where the hand is. */
static void note_untold(ss_untold *untold, const ss_hand_tick *now, const double place[3])
{
    const int64_t here = now->tick & (SS_UNTOLD_TICKS - 1), last = untold->noted;
    const int64_t oldest = now->tick - SS_UNTOLD_TICKS + 1;
    double fast[3];
    /* The force stood in the ticks that a late loop skipped. */
    for (int64_t tick = last >= oldest ? last + 1 : oldest; tick < now->tick; ++tick) {
        const int64_t at = tick & (SS_UNTOLD_TICKS - 1), before = last & (SS_UNTOLD_TICKS - 1);
        ss_copy3(untold->force[at], untold->force[before]);
        ss_copy3(untold->torque[at], untold->torque[before]);
        ss_copy3(untold->fast[at], untold->fast[before]);
    }
    untold->noted = now->tick;
    ss_copy3(untold->force[here], now->sent->force);
    ss_copy3(untold->torque[here], now->sent->torque);
    pass_high(&untold->force_pass, now->sent->force, now->period, untold->fast[here]);
    pass_high(&untold->place_pass, place, now->period, fast);
    ss_sub3(untold->fast_way, fast, untold->fast_place);
    ss_copy3(untold->fast_place, fast);
}

static void start_untold(ss_untold *untold, const ss_hand_tick *now)
{
    memset(untold->energy, 0, sizeof untold->energy);
    memset(untold->shaken, 0, sizeof untold->shaken);
    untold->let_in = 0.0;
    untold->since = now->tick;
    untold->is_on = true;
}

/* A device that may answer late, and tells nothing that would show how late. */
static ss_hand_verdict judge_untold(ss_untold *untold, const ss_hand_tick *now, const double way[3],
                                    const double turn[3])
{
    const double most_step = (SS_UNTOLD_TICKS - 1) / SS_UNTOLD_LAGS;
    const int64_t step = (int64_t)fmax(1.0, fmin(untold_lag / now->period + 0.5, most_step));
    const int64_t quiet = step * SS_UNTOLD_LAGS + (int64_t)(contact_gap_time / now->period);
    double energy = 0.0, shaken = 0.0;
    if (is_touched(now->sent)) {
        if (!untold->is_on) {
            start_untold(untold, now);
        }
        untold->touched = now->tick;
    }
    untold->is_on = untold->is_on && now->tick - untold->touched <= quiet;
    if (!untold->is_on) {
        return (ss_hand_verdict){SOFTSIM_VERDICT_GOOD, ""};
    }
    const double stays = exp(-now->period / untold_time);
    for (int d = 0; d < SS_UNTOLD_LAGS; ++d) {
        const int64_t at = (now->tick - (d + 1) * step) & (SS_UNTOLD_TICKS - 1);
        untold->energy[d] += ss_dot3(untold->force[at], way) + ss_dot3(untold->torque[at], turn);
        untold->shaken[d] = stays * untold->shaken[d] + ss_dot3(untold->fast[at], untold->fast_way);
        energy = fmax(energy, untold->energy[d]);
        shaken = fmax(shaken, untold->shaken[d]);
    }
    untold->let_in += now->let_in_j;
    const bool is_short = (double)(now->tick - untold->since) * now->period < untold_short;
    const double unexplained = energy - fmax(0.0, untold->let_in);
    if (is_short ? unexplained > most_untold : shaken > most_untold_shaken) {
        return (ss_hand_verdict){
            SOFTSIM_VERDICT_GUARDED,
            "the device does not tell which force it exerts, and moves so that its hand is driven "
            "if forces reach it late: have it name them (force_seq, applied_force) or correct them "
            "for the delay; or move slower"};
    }
    return (ss_hand_verdict){SOFTSIM_VERDICT_GOOD, ""};
}

/* ---- silence ---- */

static void note_force(ss_silence *silence, const double force[3], const double torque[3])
{
    if (!ss_is_finite(force, 3)) {
        return;
    }
    if (ss_norm3(force) >= ss_norm3(silence->strongest)) {
        ss_copy3(silence->strongest, force);
        ss_copy3(silence->torque, torque);
    }
    if (ss_norm3(force) <= ss_norm3(silence->weakest)) {
        ss_copy3(silence->weakest, force);
    }
}

/* What is in effect from this tick on. */
static void note_sent(ss_silence *silence, const ss_hand_tick *now)
{
    const softsim_force *sent = now->sent;
    /* Not where the server slept, and all poses are there when it wakes. */
    silence->was_let_go =
        !now->pose && (silence->was_let_go ||
                       (silence->has_pose && now->tick - silence->pose_tick >= SS_WATCHDOG_TICKS));
    if (now->pose) {
        silence->has_pose = true;
        silence->sender = now->pose->sender;
        silence->pose_tick = now->tick;
        silence->contact_j = now->contact_j;
        silence->sent_n = 0.0;
        ss_copy3(silence->applied, now->pose->applied_force);
        ss_copy3(silence->strongest, sent->force);
        ss_copy3(silence->weakest, sent->force);
        ss_copy3(silence->torque, sent->torque);
        note_force(silence, silence->applied, sent->torque);
    }
    silence->sent_n = fmax(silence->sent_n, ss_norm3(sent->force));
    note_force(silence, sent->force, sent->torque);
}

/* J, on the way from the last pose to this one. */
static double given_unseen(const ss_silence *silence, const softsim_pose *pose, const double way[3],
                           const double turn[3])
{
    double force[3];
    ss_add3(force, silence->applied, pose->applied_force);
    ss_scale3(force, force, 0.5);
    const bool is_corrected = (pose->flags & SOFTSIM_POSE_CORRECTS) != 0 && ss_is_finite(force, 3);
    const double given =
        is_corrected ? ss_dot3(force, way)
                     : fmax(ss_dot3(silence->strongest, way), ss_dot3(silence->weakest, way));
    return given + ss_dot3(silence->torque, turn);
}

/* J, that the contact has handed out with it. */
static double add_unseen(ss_silence *silence, const ss_hand_tick *now, double given)
{
    const double handed_out = silence->unseen_j + given - silence->contact_j;
    silence->unseen_j = fmax(silence->unseen_j, handed_out + now->contact_j);
    return handed_out;
}

/* A force that went on while nobody knew where the hand was. */
static ss_hand_verdict judge_silence(ss_silence *silence, const ss_hand_tick *now, double let_in,
                                     const double way[3], const double turn[3])
{
    const double ticks = (double)(now->tick - silence->pose_tick);
    const double interval = ticks / (1.0 + fmax(0.0, now->superseded));
    const double usual = fmin(silence->usual > 0.0 ? silence->usual : interval, SS_WATCHDOG_TICKS);
    const double longest = fmin(usual * now->period, silence_time) + silence_time;
    silence->usual = usual + usual_share * (fmin(interval, SS_WATCHDOG_TICKS) - usual);
    if (silence->was_let_go && silence->sent_n > contact_force) {
        silence->unseen_j = 0.0;
        return (ss_hand_verdict){
            SOFTSIM_VERDICT_GUARDED,
            "poses stopped for 50 ticks or more in contact: the force stayed, and was then let go; "
            "see that the device's program sends them without a break, and that nothing on the "
            "way to the server holds them up"};
    }
    const double given = given_unseen(silence, now->pose, way, turn);
    const bool is_unseen = ss_norm3(silence->strongest) > contact_force &&
                           ticks < SS_WATCHDOG_TICKS && interval * now->period >= longest;
    const double handed_out =
        is_unseen ? add_unseen(silence, now, given) : silence->unseen_j - now->contact_j;
    const bool is_known = !is_unseen && !(silence->unseen_j > 0.0);
    silence->unseen_j = now->contact_j == 0.0 ? 0.0 : silence->unseen_j;
    if (!is_known && handed_out - fmax(0.0, let_in) > most_handed_out) {
        return (ss_hand_verdict){
            SOFTSIM_VERDICT_GUARDED,
            "poses stopped for 20 ms or more in contact, and the force of where the hand had been "
            "may have handed it more than 10 mJ: see that the device's program sends them without "
            "a break, and that nothing on the way to the server holds them up"};
    }
    return (ss_hand_verdict){SOFTSIM_VERDICT_GOOD, ""};
}

void ss_hand_watch_tick(ss_hand_watch *watch, const ss_hand_tick *now)
{
    double handed_out = 0.0, given[SS_SUPPLY_DEVICES] = {0.0};
    if (now->pose && watch->sender_epoch != now->sender_epoch) {
        /* Another device, or the same from elsewhere: the distance between the two poses is not
         * counted as motion. */
        *watch = (ss_hand_watch){.sender_epoch = now->sender_epoch,
                                 .last_verdict = watch->last_verdict,
                                 .until = watch->until,
                                 .device_j = now->device_j,
                                 .others_j = now->others_j,
                                 .load_work = watch->load_work,
                                 .silence = watch->silence};
    }
    const bool is_spell = is_spell_on(watch, now);
    const bool is_counted = is_spell || now->contact_j != 0.0;
    watch->let_in = (is_counted ? watch->let_in : 0.0) + now->let_in_j;
    double way[3] = {0.0}, turn[3] = {0.0};
    if (now->pose) {
        move_hand(watch, now->pose, way, turn);
    }
    if (now->pose && now->is_lockstep) {
        for (int d = 0; d < SS_HAND_WATCH_DELAYS; ++d) {
            given[d] = ss_dot3(watch->force[d], way) + ss_dot3(watch->torque[d], turn);
        }
        handed_out = add_up(watch, given, is_spell);
        take_answer(watch, now);
    }
    if (is_touched(now->sent)) {
        watch->touched = now->tick;
    }
    /* Without a name the observer guesses which force was in effect. */
    const bool is_named =
        now->pose && (now->pose->force_seq >= 0 || ss_is_finite(now->pose->applied_force, 3));
    const double lost = add_lost(watch, now, way, is_counted);
    handed_out = is_named ? fmax(handed_out, fmax(0.0, lost) - now->contact_j) : handed_out;
    given[SS_HAND_WATCH_NAMED] = is_named ? now->device_j - watch->device_j : 0.0;
    watch->device_j = now->device_j;
    const double made = judge_parts(watch, now, given, is_counted);
    ss_hand_verdict found = ss_hand_verdict_worse(
        ss_hand_verdict_worse(judge_hand(handed_out, watch->let_in, made), judge_trail(watch, now)),
        judge_shaking(watch, now));
    if (now->pose && !now->is_lockstep) {
        ss_silence *silence = &watch->silence;
        if (silence->has_pose && silence->sender == now->pose->sender) {
            found =
                ss_hand_verdict_worse(found, judge_silence(silence, now, watch->let_in, way, turn));
        } else {
            *silence = (ss_silence){.has_pose = false};
        }
    }
    note_sent(&watch->silence, now);
    const bool is_told =
        now->pose ? is_named || (now->pose->flags & SOFTSIM_POSE_CORRECTS) != 0 : watch->is_told;
    watch->is_told = is_told;
    if (watch->has_pose) {
        note_untold(&watch->untold, now, watch->position);
    }
    if (is_told || now->is_lockstep) {
        watch->untold.is_on = false;
    } else {
        found = ss_hand_verdict_worse(found, judge_untold(&watch->untold, now, way, turn));
    }
    if (found.verdict != SOFTSIM_VERDICT_GOOD) {
        watch->last_verdict = ss_hand_verdict_worse(found, ss_hand_watch_verdict(watch, now->tick));
        watch->until = now->tick + (int64_t)ceil(tell_time / now->period);
    }
}

ss_hand_verdict ss_hand_watch_verdict(const ss_hand_watch *watch, int64_t tick)
{
    return tick < watch->until ? watch->last_verdict : (ss_hand_verdict){SOFTSIM_VERDICT_GOOD, ""};
}

ss_hand_verdict ss_hand_verdict_worse(ss_hand_verdict a, ss_hand_verdict b)
{
    return b.verdict > a.verdict ? b : a;
}
