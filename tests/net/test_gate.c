/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * net/gate: which poses may move a probe, told by reason, and when a refused sender is let in
 * again. Time is given by hand.
 */
#include "common/test.h"

#include <math.h>
#include <string.h>

#include "common/pose_fixture.h"
#include "net/net.h"

static const int64_t MS = 1000000;
static const double UNKNOWN = (double)NAN;

enum { ALICE = 1001, BOB = 2002 };

static ss_gate *gate_make(bool is_lockstep)
{
    const ss_gate_config config = {
        .used_probes = 0x05, .max_jump_m = 0.05, .period_s = 1e-3, .is_lockstep = is_lockstep};
    return ss_gate_create(&config);
}

/* A good pose of probe 0; the sender's clock is 7 s behind ours and the way takes 1 ms. */
static softsim_pose pose_make(int64_t sender, int32_t seq, int64_t now_ns)
{
    return (softsim_pose){.utime_us = (now_ns - 1 * MS) / 1000 - 7000000,
                          .sender = sender,
                          .seq = seq,
                          .position = {0.1, 0.2, 0.3},
                          PLAIN_POSE};
}

static softsim_refusal judge(ss_gate *gate, const softsim_pose *pose, int64_t now_ns)
{
    uint32_t epoch = 0;
    return ss_gate_judge(gate, pose, 0, now_ns, &epoch);
}

/* One of ALICE that is `late_ms` under way. */
static softsim_refusal judge_late(ss_gate *gate, int32_t seq, int64_t now_ms, int64_t late_ms)
{
    softsim_pose pose = pose_make(ALICE, seq, now_ms * MS);
    pose.utime_us -= late_ms * 1000;
    return judge(gate, &pose, now_ms * MS);
}

/* Sends a pose of `sender` at now_ns and gives the epoch too. */
static softsim_refusal offer(ss_gate *gate, int64_t sender, int32_t seq, int64_t now_ns,
                             uint32_t *out_epoch)
{
    const softsim_pose pose = pose_make(sender, seq, now_ns);
    return ss_gate_judge(gate, &pose, 0, now_ns, out_epoch);
}

/* A gate that has let ALICE in, by her pose 1 at now_ns. */
static ss_gate *gate_of_alice(bool is_lockstep, int64_t now_ns)
{
    ss_gate *gate = gate_make(is_lockstep);
    uint32_t epoch = 0;
    assert_int_equal(offer(gate, ALICE, 1, now_ns, &epoch), SOFTSIM_ACCEPTED);
    return gate;
}

/* One pose of ALICE a millisecond until `count`, seq 1 and on, each accepted. */
static void offer_each_ms(ss_gate *gate, int32_t count)
{
    uint32_t epoch = 0;
    for (int32_t i = 0; i < count; ++i) {
        assert_int_equal(offer(gate, ALICE, i + 1, i * MS, &epoch), SOFTSIM_ACCEPTED);
    }
}

/* Changes a good pose. */
#define CHANGE(name, ...)                                                                          \
    static void name(softsim_pose *p)                                                              \
    {                                                                                              \
        __VA_ARGS__;                                                                               \
    }

CHANGE(set_nan_position, p->position[1] = UNKNOWN)
CHANGE(set_infinite_position, p->position[2] = -HUGE_VAL)
CHANGE(set_nan_orientation, p->orientation[3] = UNKNOWN)
CHANGE(set_zero_orientation, p->orientation[0] = 0.0)
CHANGE(set_long_orientation, p->orientation[0] = 1.0011)
CHANGE(set_short_orientation, p->orientation[0] = 0.9989)
CHANGE(set_nearly_unit, p->orientation[0] = 1.0009)
CHANGE(set_huge_orientation, p->orientation[0] = 1e300)
CHANGE(set_known_velocity, p->velocity[0] = p->velocity[1] = p->velocity[2] = 0.5)
CHANGE(set_partial_velocity, p->velocity[1] = 0.0)
CHANGE(set_infinite_velocity, set_known_velocity(p); p->velocity[2] = HUGE_VAL)
CHANGE(set_absurd_velocity, set_known_velocity(p); p->velocity[0] = -1e4)
CHANGE(set_known_force, p->applied_force[0] = p->applied_force[1] = p->applied_force[2] = -3.0)
CHANGE(set_partial_force, p->applied_force[0] = 0.0)
CHANGE(set_infinite_force, set_known_force(p); p->applied_force[0] = HUGE_VAL)
CHANGE(set_absurd_force, set_known_force(p); p->applied_force[1] = 1e9)
CHANGE(set_other_probe, p->probe = 2)
CHANGE(set_negative_probe, p->probe = -1)
CHANGE(set_far_away, p->position[0] = 101.0)
CHANGE(set_edge_of_world, p->position[0] = -99.0)
CHANGE(set_nothing, (void)p)

TEST(each_first_pose_is_judged_by_its_fault)
{
    static const struct {
        const char *name;
        void (*spoil)(softsim_pose *pose);
        int32_t channel;
        softsim_refusal expected;
    } cases[] = {
        {"good", set_nothing, 0, SOFTSIM_ACCEPTED},
        {"nearly unit", set_nearly_unit, 0, SOFTSIM_ACCEPTED},
        {"known velocity", set_known_velocity, 0, SOFTSIM_ACCEPTED},
        {"known force", set_known_force, 0, SOFTSIM_ACCEPTED},
        {"edge of the world", set_edge_of_world, 0, SOFTSIM_ACCEPTED},
        {"nan position", set_nan_position, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"infinite position", set_infinite_position, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"nan orientation", set_nan_orientation, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"zero orientation", set_zero_orientation, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"long orientation", set_long_orientation, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"short orientation", set_short_orientation, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"huge orientation", set_huge_orientation, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"partial velocity", set_partial_velocity, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"infinite velocity", set_infinite_velocity, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"absurd velocity", set_absurd_velocity, 0, SOFTSIM_REFUSED_OTHER},
        {"partial force", set_partial_force, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"infinite force", set_infinite_force, 0, SOFTSIM_REFUSED_NOT_FINITE},
        {"absurd force", set_absurd_force, 0, SOFTSIM_REFUSED_OTHER},
        {"names another probe", set_other_probe, 0, SOFTSIM_REFUSED_WRONG_PROBE},
        {"names the used probe of its channel", set_other_probe, 2, SOFTSIM_ACCEPTED},
        {"negative probe", set_negative_probe, -1, SOFTSIM_REFUSED_WRONG_PROBE},
        {"channel beyond", set_nothing, 8, SOFTSIM_REFUSED_WRONG_PROBE},
        {"far away", set_far_away, 0, SOFTSIM_REFUSED_JUMP},
    };
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
        for (int lockstep = 0; lockstep < 2; ++lockstep) {
            ss_gate *gate = gate_make(lockstep != 0);
            softsim_pose pose = pose_make(ALICE, 1, 100 * MS);
            cases[c].spoil(&pose);
            uint32_t epoch = 0;
            const softsim_refusal found =
                ss_gate_judge(gate, &pose, cases[c].channel, 100 * MS, &epoch);
            if (found != cases[c].expected) {
                fail_msg("%s: %d instead of %d", cases[c].name, found, cases[c].expected);
            }
            ss_gate_counts counts;
            ss_gate_read(gate, &counts);
            assert_int_equal(counts.received, 1);
            for (int r = 0; r < SOFTSIM_REFUSED_COUNT; ++r) {
                assert_int_equal(counts.refused[r], r == (int)found);
            }
            assert_int_equal(epoch, found == SOFTSIM_ACCEPTED);
            ss_gate_destroy(&gate);
            assert_null(gate);
        }
    }
}

TEST(a_probe_without_a_tool_is_the_wrong_probe)
{
    ss_gate *gate = gate_make(false);
    softsim_pose pose = pose_make(ALICE, 1, 0);
    pose.probe = 1;
    uint32_t epoch = 0;
    assert_int_equal(ss_gate_judge(gate, &pose, 1, 0, &epoch), SOFTSIM_REFUSED_WRONG_PROBE);
    ss_gate_destroy(&gate);
}

TEST(orientations_that_pass_become_unit_ones)
{
    softsim_pose pose = pose_make(ALICE, 1, 0);
    const double q[4] = {0.5004, -0.5, 0.5, 0.5};
    memcpy(pose.orientation, q, sizeof q);
    ss_gate_normalize(&pose);
    double square = 0.0;
    for (int i = 0; i < 4; ++i) {
        square += pose.orientation[i] * pose.orientation[i];
    }
    assert_true(fabs(square - 1.0) < 1e-15);
    /* One that does not pass is left as it is, to be refused. */
    set_long_orientation(&pose);
    const softsim_pose before = pose;
    ss_gate_normalize(&pose);
    assert_memory_equal(pose.orientation, before.orientation, sizeof pose.orientation);
    set_nan_orientation(&pose);
    ss_gate_normalize(&pose);
    ss_gate *gate = gate_make(false);
    assert_int_equal(judge(gate, &pose, 0), SOFTSIM_REFUSED_NOT_FINITE);
    ss_gate_destroy(&gate);
}

TEST(repeated_and_older_poses_are_refused)
{
    for (int lockstep = 0; lockstep < 2; ++lockstep) {
        ss_gate *gate = gate_make(lockstep != 0);
        uint32_t epoch = 0;
        assert_int_equal(offer(gate, ALICE, 5, 1 * MS, &epoch), SOFTSIM_ACCEPTED);
        assert_int_equal(offer(gate, ALICE, 5, 2 * MS, &epoch), SOFTSIM_REFUSED_OTHER);
        assert_int_equal(offer(gate, ALICE, 4, 3 * MS, &epoch), SOFTSIM_REFUSED_OTHER);
        assert_int_equal(offer(gate, ALICE, 9, 4 * MS, &epoch), SOFTSIM_ACCEPTED);
        assert_int_equal(offer(gate, ALICE, 8, 5 * MS, &epoch), SOFTSIM_REFUSED_OTHER);
        ss_gate_destroy(&gate);
    }
}

TEST(seq_may_wrap)
{
    ss_gate *gate = gate_make(false);
    uint32_t epoch = 0;
    assert_int_equal(offer(gate, ALICE, INT32_MAX, 1 * MS, &epoch), SOFTSIM_ACCEPTED);
    assert_int_equal(offer(gate, ALICE, INT32_MIN, 2 * MS, &epoch), SOFTSIM_ACCEPTED);
    assert_int_equal(offer(gate, ALICE, INT32_MAX, 3 * MS, &epoch), SOFTSIM_REFUSED_OTHER);
    ss_gate_destroy(&gate);
}

TEST(the_first_sender_keeps_the_probe_until_half_a_second_of_silence)
{
    ss_gate *gate = gate_make(false);
    uint32_t epoch = 0;
    int32_t seq = 0;
    for (int64_t ms = 0; ms < 1000; ms += 10) {
        assert_int_equal(offer(gate, ALICE, ++seq, ms * MS, &epoch), SOFTSIM_ACCEPTED);
        assert_int_equal(offer(gate, BOB, seq, ms * MS, &epoch), SOFTSIM_REFUSED_OTHER_SENDER);
        assert_int_equal(epoch, 1);
    }
    /* Alice was last seen at 990 ms. */
    assert_int_equal(offer(gate, BOB, 500, 1489 * MS, &epoch), SOFTSIM_REFUSED_OTHER_SENDER);
    /* A bad pose takes nothing over. */
    softsim_pose far = pose_make(BOB, 501, 1491 * MS);
    set_far_away(&far);
    assert_int_equal(judge(gate, &far, 1491 * MS), SOFTSIM_REFUSED_JUMP);
    assert_int_equal(offer(gate, ALICE, ++seq, 1492 * MS, &epoch), SOFTSIM_ACCEPTED);
    assert_int_equal(epoch, 2); /* back after the watchdog */
    assert_int_equal(offer(gate, BOB, 502, 1991 * MS, &epoch), SOFTSIM_REFUSED_OTHER_SENDER);
    assert_int_equal(offer(gate, BOB, 503, 1992 * MS, &epoch), SOFTSIM_ACCEPTED);
    assert_int_equal(epoch, 3);
    assert_int_equal(offer(gate, ALICE, ++seq, 1993 * MS, &epoch), SOFTSIM_REFUSED_OTHER_SENDER);
    ss_gate_destroy(&gate);
}

TEST(ownership_in_lockstep_runs_on_simulated_time)
{
    ss_gate *gate = gate_of_alice(true, 1 * MS);
    uint32_t epoch = 0;
    for (int64_t tick = 2; tick <= 500; ++tick) {
        assert_int_equal(offer(gate, BOB, (int32_t)tick, tick * MS, &epoch),
                         SOFTSIM_REFUSED_OTHER_SENDER);
    }
    assert_int_equal(offer(gate, BOB, 501, 501 * MS, &epoch), SOFTSIM_ACCEPTED);
    ss_gate_destroy(&gate);
}

TEST(probes_are_held_each_by_itself)
{
    ss_gate *gate = gate_of_alice(false, 1 * MS);
    uint32_t epoch = 0;
    softsim_pose pose = pose_make(BOB, 1, 1 * MS);
    pose.probe = 2;
    assert_int_equal(ss_gate_judge(gate, &pose, 2, 1 * MS, &epoch), SOFTSIM_ACCEPTED);
    assert_int_equal(epoch, 1);
    ss_gate_destroy(&gate);
}

TEST(a_jump_is_refused_until_the_watchdog_lets_go)
{
    for (int lockstep = 0; lockstep < 2; ++lockstep) {
        ss_gate *gate = gate_of_alice(lockstep != 0, 1 * MS);
        uint32_t epoch = 0;
        softsim_pose pose = pose_make(ALICE, 2, 2 * MS);
        pose.position[0] += 0.0499;
        assert_int_equal(judge(gate, &pose, 2 * MS), SOFTSIM_ACCEPTED);
        /* From the last accepted one, however often it is tried. */
        for (int64_t tick = 3; tick <= 52; ++tick) {
            pose = pose_make(ALICE, (int32_t)tick, tick * MS);
            pose.position[0] += 0.0499 + 0.0501;
            assert_int_equal(judge(gate, &pose, tick * MS), SOFTSIM_REFUSED_JUMP);
        }
        /* Fifty ticks, 3 to 52, went without a good pose. */
        pose.seq = 53;
        assert_int_equal(ss_gate_judge(gate, &pose, 0, 53 * MS, &epoch), SOFTSIM_ACCEPTED);
        assert_int_equal(epoch, 2);
        pose.seq = 54;
        pose.position[1] += 0.04;
        assert_int_equal(ss_gate_judge(gate, &pose, 0, 54 * MS, &epoch), SOFTSIM_ACCEPTED);
        assert_int_equal(epoch, 2);
        ss_gate_set_max_jump(gate, 0.01);
        pose.seq = 55;
        pose.position[1] += 0.04;
        assert_int_equal(judge(gate, &pose, 55 * MS), SOFTSIM_REFUSED_JUMP);
        ss_gate_destroy(&gate);
    }
}

TEST(fifty_ticks_are_counted_exactly_at_any_rate)
{
    const double rate[] = {1000.0, 3000.0, 700.0, 64.0};
    for (size_t r = 0; r < sizeof rate / sizeof rate[0]; ++r) {
        const ss_gate_config config = {
            .used_probes = 1, .max_jump_m = 0.05, .period_s = 1.0 / rate[r], .is_lockstep = true};
        ss_gate *gate = ss_gate_create(&config);
        int32_t seq = 0;
        uint32_t epoch = 0;
        int64_t tick = 1;
        for (int round = 0; round < 200; ++round) {
            /* A gap of 49 missed ticks keeps the epoch, one of 50 ends it. */
            const int64_t now_ns = llround((double)tick * config.period_s * 1e9);
            const softsim_pose pose = pose_make(ALICE, ++seq, now_ns);
            assert_int_equal(ss_gate_judge(gate, &pose, 0, now_ns, &epoch), SOFTSIM_ACCEPTED);
            assert_int_equal(epoch, 1 + round / 2);
            tick += round % 2 == 0 ? 50 : 51;
        }
        ss_gate_destroy(&gate);
    }
}

TEST(old_poses_are_stale_in_real_time_only)
{
    for (int lockstep = 0; lockstep < 2; ++lockstep) {
        ss_gate *gate = gate_of_alice(lockstep != 0, 1000 * MS);
        softsim_pose pose = pose_make(ALICE, 2, 1010 * MS);
        pose.utime_us -= 49000;
        assert_int_equal(judge(gate, &pose, 1010 * MS), SOFTSIM_ACCEPTED);
        pose.seq = 3;
        pose.utime_us -= 2000;
        assert_int_equal(judge(gate, &pose, 1010 * MS),
                         lockstep ? SOFTSIM_ACCEPTED : SOFTSIM_REFUSED_STALE);
        ss_gate_destroy(&gate);
    }
}

TEST(age_is_measured_against_the_last_ten_seconds)
{
    ss_gate *gate = gate_make(false);
    uint32_t epoch = 0;
    int32_t seq = 0;
    /* One pose came 60 ms quicker than all others after it: those are stale until it is forgotten
     * or half a second has passed. */
    assert_int_equal(offer(gate, ALICE, ++seq, 1 * MS, &epoch), SOFTSIM_ACCEPTED);
    assert_int_equal(judge_late(gate, ++seq, 2, 30), SOFTSIM_ACCEPTED);
    /* 30 ms late for 9 s: accepted all along, since it was never more than 50. */
    for (int64_t ms = 10; ms < 9000; ms += 10) {
        assert_int_equal(judge_late(gate, ++seq, ms, 30), SOFTSIM_ACCEPTED);
    }
    assert_int_equal(judge_late(gate, ++seq, 9000, 60), SOFTSIM_REFUSED_STALE);
    for (int64_t ms = 9010; ms < 11010; ms += 10) {
        assert_int_equal(judge_late(gate, ++seq, ms, 30), SOFTSIM_ACCEPTED);
    }
    /* The quick pose is out of the window: 60 ms is 30 ms more than the least now. */
    assert_int_equal(judge_late(gate, ++seq, 11010, 60), SOFTSIM_ACCEPTED);
    ss_gate_destroy(&gate);
}

TEST(a_sender_back_after_long_silence_is_not_held_to_its_old_delays)
{
    ss_gate *gate = gate_of_alice(false, 1 * MS);
    assert_int_equal(judge_late(gate, 2, 20000, 60), SOFTSIM_ACCEPTED);
    ss_gate_destroy(&gate);
}

TEST(a_sender_that_is_always_stale_starts_afresh_after_half_a_second)
{
    ss_gate *gate = gate_make(false);
    uint32_t epoch = 0;
    int32_t seq = 100;
    offer_each_ms(gate, seq);
    /* Its clock is set back by an hour. */
    int64_t ms = 100;
    for (; ms < 600; ++ms) {
        assert_int_equal(judge_late(gate, ++seq, ms, 3600 * 1000), SOFTSIM_REFUSED_STALE);
    }
    softsim_pose pose = pose_make(ALICE, ++seq, ms * MS);
    pose.utime_us -= (int64_t)3600 * 1000000;
    assert_int_equal(ss_gate_judge(gate, &pose, 0, ms * MS, &epoch), SOFTSIM_ACCEPTED);
    assert_int_equal(epoch, 2);
    for (++ms; ms < 700; ++ms) {
        pose.seq = ++seq;
        pose.utime_us += 1000;
        assert_int_equal(judge(gate, &pose, ms * MS), SOFTSIM_ACCEPTED);
    }
    ss_gate_destroy(&gate);
}

TEST(one_timely_pose_ends_the_count_to_a_fresh_start)
{
    ss_gate *gate = gate_make(false);
    uint32_t epoch = 0;
    int32_t seq = 0;
    for (int64_t ms = 0; ms < 3000; ++ms) {
        softsim_pose pose = pose_make(ALICE, ++seq, ms * MS);
        const bool is_late = ms % 400 != 0;
        pose.utime_us -= is_late ? 80000 : 0;
        assert_int_equal(ss_gate_judge(gate, &pose, 0, ms * MS, &epoch),
                         is_late ? SOFTSIM_REFUSED_STALE : SOFTSIM_ACCEPTED);
    }
    ss_gate_destroy(&gate);
}

TEST(a_log_played_twice_by_the_same_sender_gets_in_again)
{
    ss_gate *gate = gate_make(false);
    offer_each_ms(gate, 2000);
    int32_t accepted = 0;
    for (int32_t i = 0; i < 2000; ++i) {
        softsim_pose pose = pose_make(ALICE, i + 1, i * MS);
        accepted += judge(gate, &pose, (2000 + i) * MS) == SOFTSIM_ACCEPTED;
    }
    /* 50 ms by seq, then 500 ms by age. */
    assert_in_range(accepted, 1440, 1460);
    ss_gate_destroy(&gate);
}

TEST(hostile_times_overflow_nothing)
{
    const int64_t time[] = {INT64_MIN, INT64_MIN + 1, -1, 0, 1, INT64_MAX - 1, INT64_MAX};
    enum { COUNT = sizeof time / sizeof time[0] };
    for (int i = 0; i < COUNT * COUNT; ++i) {
        ss_gate *gate = gate_make(false);
        softsim_pose pose = pose_make(ALICE, 1, 5 * MS);
        pose.utime_us = time[i / COUNT];
        assert_int_equal(judge(gate, &pose, 5 * MS), SOFTSIM_ACCEPTED);
        pose.seq = 2;
        pose.utime_us = time[i % COUNT];
        const softsim_refusal second = judge(gate, &pose, 6 * MS);
        assert_true(second == SOFTSIM_ACCEPTED || second == SOFTSIM_REFUSED_STALE);
        ss_gate_destroy(&gate);
    }
}

/* Every force tells the holder's number to all who listen; its address is its own. */
TEST(a_holder_is_its_address_too)
{
    const bool lockstep[] = {false, true};
    for (int i = 0; i < 2; ++i) {
        ss_gate *gate = gate_make(lockstep[i]);
        softsim_pose holder = pose_make(ALICE, 1, 5 * MS);
        holder.source = 0x7f000001aaaa;
        assert_int_equal(judge(gate, &holder, 5 * MS), SOFTSIM_ACCEPTED);
        softsim_pose liar = pose_make(ALICE, 1000000000, 6 * MS);
        liar.source = 0x7f000001bbbb;
        assert_int_equal(judge(gate, &liar, 6 * MS), SOFTSIM_REFUSED_OTHER_SENDER);
        /* An answer to it would tell the holder that somebody else holds its probe. */
        assert_false(ss_gate_may_answer_other(gate, &liar, 0, 6 * MS));
        holder.seq = 2;
        holder.utime_us += 2000;
        assert_int_equal(judge(gate, &holder, 7 * MS), SOFTSIM_ACCEPTED);
        /* A client that is started again on another port waits as any other does. */
        assert_int_equal(judge(gate, &liar, 400 * MS), SOFTSIM_REFUSED_OTHER_SENDER);
        liar.utime_us += 600000;
        assert_int_equal(judge(gate, &liar, 606 * MS), SOFTSIM_ACCEPTED);
        ss_gate_destroy(&gate);
    }
}

TEST(other_senders_are_answered_ten_times_a_second)
{
    ss_gate *gate = gate_make(false);
    const softsim_pose other = pose_make(BOB, 1, 0);
    int answers[SOFTSIM_MAX_PROBES] = {0};
    for (int64_t ms = 0; ms < 2000; ++ms) {
        for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
            answers[p] += ss_gate_may_answer_other(gate, &other, p, ms * MS);
        }
    }
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        assert_int_equal(answers[p], 20);
    }
    assert_false(ss_gate_may_answer_other(gate, &other, -1, 0));
    assert_false(ss_gate_may_answer_other(gate, &other, 8, 0));
    ss_gate_destroy(&gate);
    gate = gate_make(true);
    assert_true(ss_gate_may_answer_other(gate, &other, 0, 1));
    assert_true(ss_gate_may_answer_other(gate, &other, 0, 2));
    ss_gate_destroy(&gate);
}

/* received - malformed - wrong type is what moved a lockstep server's time. */
TEST(a_refused_command_is_no_pose)
{
    ss_gate *gate = gate_make(true);
    ss_gate_counts counts;
    ss_gate_refuse(gate, SOFTSIM_REFUSED_MALFORMED);
    ss_gate_refuse_command(gate);
    ss_gate_refuse_command(gate);
    ss_gate_read(gate, &counts);
    assert_int_equal(counts.received, 1);
    assert_int_equal(counts.refused[SOFTSIM_REFUSED_MALFORMED], 1);
    assert_int_equal(counts.refused[SOFTSIM_REFUSED_OTHER], 2);
    ss_gate_destroy(&gate);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
