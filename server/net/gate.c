/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "net/gate.h"
/*
 * The receive checks: which poses may move a probe. No LCM, no clock: the same decisions on the
 * same poses in the daemon, in lockstep and in headless runs.
 *
 * In this order, the first that fails names the refusal:
 *   wrong probe    the channel's probe has no tool, or the pose names another one
 *   not finite     position or orientation; | |q| - 1 | > 1e-3; velocity or applied force that is
 *                  infinite or only partly NaN (NaN as a whole means unknown)
 *   other          velocity or force beyond any device (1 km/s, 1 MN in a coordinate)
 *   other sender   somebody else holds the probe: the first sender keeps it until no finite pose
 *                  of it came for 0.5 s and then a good one of another sender does. A sender is its
 *                  number and the address that its poses come from: every force tells the number
 *                  to all who listen
 *   other          seq not newer than the last accepted one (UDP may repeat and reorder)
 *   stale          older than 50 ms. The clocks of two hosts differ by an unknown offset, so age
 *                  is measured against the quickest pose seen: with d = receive time - utime,
 *                  age = d - min(d of the poses accepted in the last 10 s), the minima kept per
 *                  second. A sender all of whose poses were stale for 0.5 s (its clock was set,
 *                  a log was started again) starts afresh
 *   jump           further than max_jump from the last accepted pose, or more than 100 m in a
 *                  coordinate, which also bounds the first pose
 * After 50 haptic periods without a good pose the force has been ramped away and the tool is out of
 * the world: the next good pose is taken wherever it is and whatever its seq, as a new epoch.
 * Alternative rejected: judging age by the hosts' wall clocks, which need not agree.
 */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

enum {
    WATCHDOG_PERIODS = 50,
    AGE_SECONDS = 10,
    AGE_BUCKETS = AGE_SECONDS + 1 /* ten whole seconds and the current one */
};
static const int64_t NS_PER_S = 1000000000;
static const int64_t HOLD_NS = 500000000;
static const int64_t FRESH_START_NS = 500000000;
static const int64_t ANSWER_NS = 100000000;
static const int64_t MAX_AGE_US = 50000;
static const double MAX_UNIT_ERROR = 1e-3;
static const double MAX_VELOCITY_M_S = 1e3;
static const double MAX_FORCE_N = 1e6;

/* The least receive time - utime of one second. */
typedef struct age_bucket {
    bool is_used;
    int64_t second;
    int64_t least_us;
} age_bucket;

/* One probe and the sender that holds it. */
typedef struct gate_probe {
    bool has_holder;
    int64_t sender;
    uint64_t source;
    int64_t seen_ns; /* its last finite pose, accepted or not */
    uint32_t epoch;
    /* The last accepted pose. */
    int64_t accepted_ns;
    int32_t seq;
    double position[3];
    /* Age. */
    age_bucket age[AGE_BUCKETS];
    bool is_stale; /* since stale_ns every pose was */
    int64_t stale_ns;
    /* Answers to other senders. */
    bool has_answered;
    int64_t answered_ns;
} gate_probe;

struct ss_gate {
    ss_gate_config config;
    int64_t watchdog_ns;
    gate_probe probe[SOFTSIM_MAX_PROBES];
    /* Statistics, read by any thread: relaxed. */
    atomic_int_least64_t received;
    atomic_int_least64_t refused[SOFTSIM_REFUSED_COUNT];
};

/* a - b without overflow: hostile times saturate. */
static int64_t subtract(int64_t a, int64_t b)
{
    int64_t difference = 0;
    if (__builtin_sub_overflow(a, b, &difference)) {
        return a < b ? INT64_MIN : INT64_MAX;
    }
    return difference;
}

/* ---- one pose by itself ---- */

static double quaternion_norm(const double q[4])
{
    return sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

void ss_gate_normalize(softsim_pose *pose)
{
    const double norm = quaternion_norm(pose->orientation);
    if (fabs(norm - 1.0) <= MAX_UNIT_ERROR) {
        for (int i = 0; i < 4; ++i) {
            pose->orientation[i] /= norm;
        }
    }
}

/* All finite, or all NaN: unknown. */
static bool is_known_or_unknown(const double v[3])
{
    return ss_is_finite(v, 3) || (isnan(v[0]) && isnan(v[1]) && isnan(v[2]));
}

static bool is_finite_pose(const softsim_pose *pose)
{
    return ss_is_finite(pose->position, 3) && ss_is_finite(pose->orientation, 4) &&
           fabs(quaternion_norm(pose->orientation) - 1.0) <= MAX_UNIT_ERROR &&
           is_known_or_unknown(pose->velocity) && is_known_or_unknown(pose->applied_force);
}

/* Written so that NaN, which means unknown, is not beyond. */
static bool is_beyond(const double v[3], double limit)
{
    return fabs(v[0]) > limit || fabs(v[1]) > limit || fabs(v[2]) > limit;
}

/* ---- age ---- */

static void note_age(gate_probe *probe, int64_t now_ns, int64_t offset_us)
{
    const int64_t second = now_ns / NS_PER_S;
    age_bucket *bucket = &probe->age[(uint64_t)second % AGE_BUCKETS];
    if (!bucket->is_used || bucket->second != second) {
        *bucket = (age_bucket){.is_used = true, .second = second, .least_us = offset_us};
    } else if (offset_us < bucket->least_us) {
        bucket->least_us = offset_us;
    }
}

/* False also when nothing is known to compare with. */
static bool is_too_old(const gate_probe *probe, int64_t now_ns, int64_t offset_us)
{
    const int64_t second = now_ns / NS_PER_S;
    int64_t least_us = offset_us;
    for (int b = 0; b < AGE_BUCKETS; ++b) {
        const age_bucket *bucket = &probe->age[b];
        if (bucket->is_used && second - bucket->second <= AGE_SECONDS &&
            bucket->least_us < least_us) {
            least_us = bucket->least_us;
        }
    }
    return subtract(offset_us, least_us) > MAX_AGE_US;
}

/* Stale unless it was so for long enough to start afresh. */
static bool is_stale(gate_probe *probe, int64_t now_ns, int64_t offset_us)
{
    if (!is_too_old(probe, now_ns, offset_us)) {
        probe->is_stale = false;
        return false;
    }
    if (!probe->is_stale) {
        probe->is_stale = true;
        probe->stale_ns = now_ns;
    }
    if (now_ns - probe->stale_ns < FRESH_START_NS) {
        return true;
    }
    probe->is_stale = false;
    memset(probe->age, 0, sizeof probe->age);
    return false;
}

/* ---- one probe ---- */

/* Judges a pose of the sender that holds the probe, or of the first one. */
static softsim_refusal judge_motion(const ss_gate *gate, gate_probe *probe,
                                    const softsim_pose *pose, int64_t now_ns, bool is_return)
{
    /* Unsigned difference: seq may wrap. */
    const int32_t newer = (int32_t)((uint32_t)pose->seq - (uint32_t)probe->seq);
    if (!is_return && newer <= 0) {
        return SOFTSIM_REFUSED_OTHER;
    }
    const int64_t offset_us = subtract(now_ns / 1000, pose->utime_us);
    if (!gate->config.is_lockstep && is_stale(probe, now_ns, offset_us)) {
        return SOFTSIM_REFUSED_STALE;
    }
    double step[3];
    ss_sub3(step, pose->position, probe->position);
    if (is_beyond(pose->position, SOFTSIM_FARTHEST_M) ||
        (!is_return && ss_norm3(step) > gate->config.max_jump_m)) {
        return SOFTSIM_REFUSED_JUMP;
    }
    if (!gate->config.is_lockstep) {
        note_age(probe, now_ns, offset_us);
    }
    return SOFTSIM_ACCEPTED;
}

static softsim_refusal judge_probe(const ss_gate *gate, gate_probe *probe, const softsim_pose *pose,
                                   int64_t now_ns)
{
    const bool is_holder =
        probe->has_holder && pose->sender == probe->sender && pose->source == probe->source;
    if (is_holder) {
        probe->seen_ns = now_ns;
    } else if (probe->has_holder && now_ns - probe->seen_ns < HOLD_NS) {
        return SOFTSIM_REFUSED_OTHER_SENDER;
    }
    /* A new holder must not inherit anything; it takes over only by a good pose. */
    gate_probe fresh = {.epoch = probe->epoch,
                        .has_answered = probe->has_answered,
                        .answered_ns = probe->answered_ns};
    gate_probe *judged = is_holder ? probe : &fresh;
    const bool is_return = !is_holder || now_ns - probe->accepted_ns > gate->watchdog_ns;
    const softsim_refusal refusal = judge_motion(gate, judged, pose, now_ns, is_return);
    if (refusal != SOFTSIM_ACCEPTED) {
        return refusal;
    }
    judged->has_holder = true;
    judged->sender = pose->sender;
    judged->source = pose->source;
    judged->seen_ns = now_ns;
    judged->accepted_ns = now_ns;
    judged->seq = pose->seq;
    ss_copy3(judged->position, pose->position);
    judged->epoch += is_return ? 1u : 0u;
    if (!is_holder) {
        *probe = fresh;
    }
    return SOFTSIM_ACCEPTED;
}

/* ---- the gate ---- */

ss_gate *ss_gate_create(const ss_gate_config *config)
{
    ss_gate *gate = ss_memory_get(1, sizeof *gate);
    if (gate == NULL) {
        return NULL;
    }
    gate->config = *config;
    /* Times of ticks are rounded to 1 ns, so that fifty of them may be 1 ns longer. */
    gate->watchdog_ns = llround(WATCHDOG_PERIODS * config->period_s * 1e9) + 1;
    return gate;
}

void ss_gate_destroy(ss_gate **gate)
{
    ss_memory_free(*gate);
    *gate = NULL;
}

void ss_gate_set_max_jump(ss_gate *gate, double max_jump_m)
{
    gate->config.max_jump_m = max_jump_m;
}

bool ss_gate_may_answer_other(ss_gate *gate, const softsim_pose *pose, int32_t channel_probe,
                              int64_t now_ns)
{
    if (channel_probe < 0 || channel_probe >= SOFTSIM_MAX_PROBES) {
        return false;
    }
    gate_probe *probe = &gate->probe[channel_probe];
    if ((probe->has_holder && pose->sender == probe->sender) ||
        (!gate->config.is_lockstep && probe->has_answered &&
         now_ns - probe->answered_ns < ANSWER_NS)) {
        return false;
    }
    probe->has_answered = true;
    probe->answered_ns = now_ns;
    return true;
}

void ss_gate_refuse(ss_gate *gate, softsim_refusal reason)
{
    atomic_fetch_add_explicit(&gate->received, 1, memory_order_relaxed);
    if (reason >= 0 && reason < SOFTSIM_REFUSED_COUNT) {
        atomic_fetch_add_explicit(&gate->refused[reason], 1, memory_order_relaxed);
    }
}

void ss_gate_refuse_command(ss_gate *gate)
{
    atomic_fetch_add_explicit(&gate->refused[SOFTSIM_REFUSED_OTHER], 1, memory_order_relaxed);
}

void ss_gate_read(const ss_gate *gate, ss_gate_counts *out_counts)
{
    out_counts->received = atomic_load_explicit(&gate->received, memory_order_relaxed);
    for (int r = 0; r < SOFTSIM_REFUSED_COUNT; ++r) {
        out_counts->refused[r] = atomic_load_explicit(&gate->refused[r], memory_order_relaxed);
    }
}

softsim_refusal ss_gate_judge(ss_gate *gate, const softsim_pose *pose, int32_t channel_probe,
                              int64_t now_ns, uint32_t *out_epoch)
{
    softsim_refusal refusal = SOFTSIM_ACCEPTED;
    *out_epoch = 0;
    if (channel_probe < 0 || channel_probe >= SOFTSIM_MAX_PROBES || pose->probe != channel_probe ||
        (gate->config.used_probes >> channel_probe & 1) == 0) {
        refusal = SOFTSIM_REFUSED_WRONG_PROBE;
    } else if (!is_finite_pose(pose)) {
        refusal = SOFTSIM_REFUSED_NOT_FINITE;
    } else if (is_beyond(pose->velocity, MAX_VELOCITY_M_S) ||
               is_beyond(pose->applied_force, MAX_FORCE_N)) {
        refusal = SOFTSIM_REFUSED_OTHER;
    } else {
        gate_probe *probe = &gate->probe[channel_probe];
        refusal = judge_probe(gate, probe, pose, now_ns);
        *out_epoch = probe->epoch;
    }
    ss_gate_refuse(gate, refusal); /* -1, accepted, counts as received only */
    return refusal;
}
