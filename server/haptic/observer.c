/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What the device's side of the loop really did: energy per contact, the loop's delay, and the
 * stiffness that this delay allows.
 *
 * Energy taken from the device over one contact: E = sum -F . (x_j - x_{j-1}) - M . turn, where F
 * is what the device exerted between the two samples: its own `applied_force`, else the force that
 * `force_seq` of pose j-1 names, else the one handed out tau before. The torque M goes with a force
 * that is named or handed out; a device that tells its own has told no torque. E starts at 0 at
 * each first touch, so that a good contact never shows a debt; negative means that the hand was
 * given energy. The server's own pairs of pose and force cannot see the delay of the way: in a
 * limit cycle they report absorption where the hand is being driven.
 *
 * Delay: tau = age, on the device's own clock, of the pose that the force in effect answers. The
 * 95th percentile of the last second counts; 5 ms until known.
 *
 * Limit: a virtual spring S with delay is stable in a hand when S (T/2 + tau) <= b_hand + B_c
 * (Colgate's bound with delay). With 2 N s/m for the softest grip and a factor 1/2,
 *   K_max = min(stiffness, 0.5 (2 + B_c)/(T/2 + tau)),
 * tau/5 for a client that corrects forces between messages. It moves by at most 20 % a second, so
 * that the hand does not feel it move, but for the first time that tau is known, which a contact
 * may have preceded: then it comes down in 50 ms. Upwards only out of contact: a loaded spring F
 * that stiffens from K to K + dK hands out F^2 dK / (2 K^2), a millijoule a second in a firm hold.
 */
#include "haptic/internal.h"

#include <string.h>

#include "rt/vec.h"

#define UNKNOWN_DELAY   0.005 /* s */
#define DELAY_WINDOW    1.0   /* s */
#define BUCKET_WIDTH    50e-6 /* s */
#define SOFTEST_GRIP    2.0   /* N s/m */
#define SAFETY          0.5   /* covers the 2 to 22 % between bound and simulated wall */
#define CORRECTION_GAIN 5.0   /* a correcting client's loop acts as if this much shorter */
#define LIMIT_RATE      0.2   /* 1/s */
#define FIRST_RATE      20.0  /* 1/s, down: until it is for the first time what the delay allows */
#define LIMIT_FLOOR     1.0   /* N/m */
#define CONTACT_FORCE   0.02  /* N: less is no contact */
/* Samples: enough for the delay; enough to see that it is longer than was thought. */
enum { KNOWN_SAMPLES = 100, FEW_SAMPLES = 20, QUANTILE_TICKS = 16 };

static const ss_past_force *find_force(const ss_observer *observer, int32_t seq)
{
    if (seq < 1 || seq > observer->last_seq) {
        return NULL;
    }
    const ss_past_force *record = &observer->history[seq & (SS_FORCE_HISTORY - 1)];
    return record->seq == seq ? record : NULL;
}

double ss_observer_rule(const ss_haptic_config *config, double delay, bool corrects)
{
    const double tau = corrects ? delay / CORRECTION_GAIN : delay;
    const double stable = SAFETY * (SOFTEST_GRIP + config->damping) / (0.5 * config->period + tau);
    return fmax(LIMIT_FLOOR, fmin(config->stiffness, stable));
}

void ss_observer_break(ss_observer *observer)
{
    observer->has_sample = false;
    observer->is_in_contact = false;
}

void ss_observer_restart(ss_observer *observer, const ss_haptic_config *config, bool corrects)
{
    ss_observer_break(observer);
    observer->sample_head = 0;
    observer->sample_count = 0;
    memset(observer->bucket_count, 0, sizeof observer->bucket_count);
    observer->is_known = observer->is_settled = false;
    observer->delay_p50 = UNKNOWN_DELAY;
    observer->delay_p95 = UNKNOWN_DELAY;
    observer->limit = ss_observer_rule(config, UNKNOWN_DELAY, corrects);
}

void ss_observer_force(ss_observer *observer, const ss_past_force *record)
{
    observer->history[record->seq & (SS_FORCE_HISTORY - 1)] = *record;
    observer->last_seq = record->seq;
}

/* Force and torque over the interval that ends with `pose`. */
static void applied_force(const ss_observer *observer, const ss_haptic_config *config,
                          const softsim_pose *pose, double out[3], double out_torque[3])
{
    ss_set3(out_torque, 0.0, 0.0, 0.0);
    if (ss_is_finite(pose->applied_force, 3)) {
        ss_copy3(out, pose->applied_force);
        return;
    }
    const ss_past_force *record = find_force(observer, observer->force_seq);
    if (record == NULL && observer->force_seq < 0) {
        const double ticks = observer->delay_p95 / config->period;
        record = find_force(observer, observer->last_seq - (int32_t)(ticks + 0.5));
    }
    if (record == NULL) {
        ss_set3(out, 0.0, 0.0, 0.0);
        return;
    }
    ss_copy3(out, record->force);
    ss_copy3(out_torque, record->torque);
}

static void add_energy(ss_observer *observer, const double force[3], const double torque[3],
                       const softsim_pose *pose)
{
    const bool is_in_contact = ss_norm3(force) > CONTACT_FORCE;
    if (is_in_contact && !observer->is_in_contact) {
        observer->energy = 0.0;
        ++observer->contacts;
    }
    observer->is_in_contact = is_in_contact;
    if (!is_in_contact) {
        return;
    }
    double move[3], turn[3];
    ss_sub3(move, pose->position, observer->x);
    ss_turn_between(observer->orientation, pose->orientation, turn);
    const double taken = -ss_dot3(force, move) - ss_dot3(torque, turn);
    if (!isfinite(taken)) {
        return;
    }
    observer->energy += taken;
    observer->from_device += fmax(0.0, taken);
    observer->to_device += fmax(0.0, -taken);
    observer->worst = fmin(observer->worst, observer->energy);
}

/* How many of the last forces the device had not yet, or not to the end, when it sent its pose. */
static int32_t forces_under_way(const ss_observer *observer, double period)
{
    const double most = SS_DELAY_BUCKETS * BUCKET_WIDTH / period;
    const double count = find_force(observer, observer->force_seq) != NULL
                             ? (double)observer->last_seq - (double)observer->force_seq + 1.0
                             : observer->delay_p95 / period;
    return (int32_t)fmin(count, fmin(most, SS_FORCE_HISTORY - 1));
}

double ss_observer_foresee(const ss_observer *observer, const ss_passivity_tick *now)
{
    const int32_t ticks = forces_under_way(observer, now->period);
    /* A contact may begin with what is under way. */
    double energy = observer->is_in_contact ? observer->energy : 0.0;
    for (int32_t k = 0; k < ticks; ++k) {
        /* In effect k ticks after the pose: each in its turn, or the last one as a client that
         * corrects will have it. */
        const ss_past_force *record =
            find_force(observer, observer->last_seq - (now->corrects ? 0 : ticks - 1 - k));
        if (record != NULL) {
            const double time = k * now->period;
            double force[3], way[3], velocity[3];
            ss_scale3(way, now->velocity, time);
            ss_madd3(way, way, 0.5 * time * time, now->acceleration);
            ss_madd3(velocity, now->velocity, time, now->acceleration);
            ss_madd3(force, record->force, now->corrects ? -now->stiffness : 0.0, way);
            const bool is_pulling = !now->is_grasping && ss_dot3(force, record->force) < 0.0;
            energy -= is_pulling ? 0.0 : ss_dot3(force, velocity) * now->period;
        }
    }
    return energy;
}

static void add_delay(ss_observer *observer, const ss_haptic_config *config,
                      const softsim_pose *pose, int64_t tick)
{
    const ss_past_force *record = find_force(observer, pose->force_seq);
    if (record == NULL) {
        return;
    }
    const double delay = config->is_lockstep
                             ? (double)(tick - record->pose_tick) * config->period
                             : ((double)pose->utime_us - (double)record->pose_utime_us) * 1e-6;
    if (!(delay > 0.0)) {
        return;
    }
    const double bounded = fmax(config->period, delay) / BUCKET_WIDTH + 0.5;
    const uint16_t bucket = (uint16_t)fmin(bounded, SS_DELAY_BUCKETS - 1);
    if (observer->sample_count == SS_DELAY_SAMPLES) {
        --observer->sample_count;
        const int32_t oldest = observer->sample_head;
        --observer->bucket_count[observer->sample_bucket[oldest]];
    }
    observer->sample_bucket[observer->sample_head] = bucket;
    observer->sample_tick[observer->sample_head] = tick;
    observer->sample_head = (observer->sample_head + 1) & (SS_DELAY_SAMPLES - 1);
    ++observer->sample_count;
    ++observer->bucket_count[bucket];
}

void ss_observer_pose(ss_observer *observer, const ss_haptic_config *config,
                      const softsim_pose *pose, int64_t tick)
{
    observer->is_told = ss_is_finite(pose->applied_force, 3) || pose->force_seq >= 0;
    if (observer->has_sample) {
        double force[3], torque[3];
        applied_force(observer, config, pose, force, torque);
        add_energy(observer, force, torque, pose);
    }
    add_delay(observer, config, pose, tick);
    observer->has_sample = true;
    ss_copy3(observer->x, pose->position);
    memcpy(observer->orientation, pose->orientation, sizeof observer->orientation);
    observer->force_seq = pose->force_seq;
}

/* Delay below which `quantile` of the samples lie. */
static double delay_quantile(const ss_observer *observer, double quantile)
{
    const double wanted = quantile * (double)observer->sample_count;
    double seen = 0.0;
    for (int i = 0; i < SS_DELAY_BUCKETS; ++i) {
        seen += (double)observer->bucket_count[i];
        if (seen >= wanted) {
            return i * BUCKET_WIDTH;
        }
    }
    return SS_DELAY_BUCKETS * BUCKET_WIDTH;
}

static void forget_old_samples(ss_observer *observer, const ss_haptic_config *config, int64_t tick)
{
    const double window = DELAY_WINDOW / config->period;
    while (observer->sample_count > 0) {
        const int32_t oldest =
            (observer->sample_head - observer->sample_count) & (SS_DELAY_SAMPLES - 1);
        if ((double)(tick - observer->sample_tick[oldest]) < window) {
            break;
        }
        --observer->bucket_count[observer->sample_bucket[oldest]];
        --observer->sample_count;
    }
}

void ss_observer_tick(ss_observer *observer, const ss_haptic_config *config, bool corrects,
                      bool is_in_contact, int64_t tick)
{
    forget_old_samples(observer, config, tick);
    const bool was_known = observer->is_known;
    if (tick % QUANTILE_TICKS == 0) {
        observer->is_known = observer->sample_count >= KNOWN_SAMPLES;
        observer->delay_p50 = observer->is_known ? delay_quantile(observer, 0.50) : UNKNOWN_DELAY;
        observer->delay_p95 = delay_quantile(observer, 0.95);
        if (!observer->is_known) {
            const bool is_some = observer->sample_count >= FEW_SAMPLES;
            observer->delay_p95 =
                is_some ? fmax(UNKNOWN_DELAY, observer->delay_p95) : UNKNOWN_DELAY;
        }
    }
    const double wanted = ss_observer_rule(config, observer->delay_p95, corrects);
    if (observer->is_known && !was_known && !is_in_contact) {
        observer->limit = wanted;
        observer->is_settled = true;
        return;
    }
    const double up = 1.0 + LIMIT_RATE * config->period;
    const bool is_first = !observer->is_settled && observer->sample_count >= FEW_SAMPLES;
    const double down = is_first ? 1.0 + FIRST_RATE * config->period : up;
    const double highest = is_in_contact ? observer->limit : observer->limit * up;
    observer->limit = fmin(highest, fmax(observer->limit / down, wanted));
    observer->is_settled =
        observer->is_settled || (observer->is_known && observer->limit <= wanted);
}
