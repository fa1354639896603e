/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Logs of sessions in which several sent on one probe: whose poses are played. */
#include "common/test.h"

#include <string.h>

#include "common/folder_fixture.h"
#include "common/pose_fixture.h"
#include "softsim/log.h"

enum { HOLDER = 11, OTHER = 22, THIRD = 33 };

static softsim_log_writer *writer;
static softsim_poses *poses;

static int close_all(void **state)
{
    softsim_log_abandon(&writer);
    softsim_poses_close(&poses);
    return remove_folder(state);
}

#define LOG_TEST(name) TEST_WITH(name, make_folder, close_all)

static void begin_log(void)
{
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(softsim_log_create(in_folder("a.lcmlog"), &writer, &error), SOFTSIM_OK);
}

static void add_pose(int ms, int64_t sender, int32_t seq, int32_t probe)
{
    char channel[32];
    const softsim_pose pose = {.sender = sender, .seq = seq, .probe = probe, PLAIN_POSE};
    snprintf(channel, sizeof channel, "SOFTSIM_PROBE_%d", probe);
    softsim_log_write_pose(writer, 1000LL * ms, channel, &pose);
}

static void add_force(int ms, int64_t sender, int32_t pose_seq, int32_t probe, bool is_refused)
{
    char channel[32];
    const softsim_force force = {.sender = sender,
                                 .pose_seq = pose_seq,
                                 .probe = probe,
                                 .flags = is_refused ? SOFTSIM_FORCE_OTHER_SENDER : 0};
    snprintf(channel, sizeof channel, "SOFTSIM_FORCE_%d", probe);
    softsim_log_write_force(writer, 1000LL * ms, channel, &force);
}

/* What is played of the log. */
static struct {
    int64_t sender[4000];
    int32_t seq[4000];
    int count, of[3]; /* of the holder, the other, the third */
    int notes;
    char note[256]; /* the last */
} played;

static void play_log(void)
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_pose_event event;
    softsim_poses_result next;
    if (writer != NULL) {
        assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
        assert_int_equal(softsim_poses_open(in_folder("a.lcmlog"), 1000.0, &poses, &error),
                         SOFTSIM_OK);
    } else {
        softsim_poses_rewind(poses);
    }
    memset(&played, 0, sizeof played);
    while ((next = softsim_poses_next(poses, &event, played.note, sizeof played.note)) !=
           SOFTSIM_POSES_END) {
        if (next == SOFTSIM_POSES_NOTE) {
            ++played.notes;
            continue;
        }
        assert_true(played.count < 4000);
        played.sender[played.count] = event.pose.sender;
        played.seq[played.count++] = event.pose.seq;
        played.of[event.pose.sender / 11 - 1] += 1;
    }
    assert_false(softsim_poses_is_damaged(poses));
}

/* A bridge holds the probe for two seconds; a replay asks for it with poses numbered 0, and another
 * client sends at once: it is told ten times a second that it is refused, until it is taken. */
LOG_TEST(what_a_server_refused_is_left_out)
{
    begin_log();
    for (int ms = 0; ms < 2000; ++ms) {
        add_pose(ms, HOLDER, ms + 1, 0);
        add_force(ms, HOLDER, ms + 1, 0, false);
        if (ms % 100 == 50) {
            add_pose(ms, THIRD, 0, 0);
            add_force(ms, THIRD, 0, 0, true);
        }
        if (ms >= 500) {
            add_pose(ms, OTHER, ms - 499, 0);
            if (ms % 100 == 0) {
                add_force(ms, OTHER, ms - 499, 0, true);
            }
        }
    }
    for (int ms = 2000; ms < 3000; ++ms) { /* held on for half a second */
        add_pose(ms, OTHER, ms - 499, 0);
        if (ms < 2500 ? ms % 100 == 0 : ms % 7 == 1) { /* not each is answered */
            add_force(ms, OTHER, ms - 499, 0, ms < 2500);
        }
    }
    for (int turn = 0; turn < 2; ++turn) { /* rewound, it is the same */
        play_log();
        assert_int_equal(played.of[0], 2000);
        assert_in_range(played.of[1], 500 - 7, 500);
        assert_int_equal(played.of[2], 0);
        for (int i = 0; i < played.count; ++i) {
            assert_int_equal(played.sender[i], i < 2000 ? HOLDER : OTHER);
        }
        assert_int_equal(played.seq[played.count - 1], 2500);
        assert_int_equal(played.notes, 1);
        char said[64];
        snprintf(said, sizeof said, "left out %d poses that were refused", 4500 - played.count);
        assert_non_null(strstr(played.note, said));
        assert_non_null(strstr(played.note, " and 20 numbered 0"));
        assert_false(softsim_poses_is_mixed(poses));
    }
}

/* The same without forces, or with the holder's alone: nothing tells. */
LOG_TEST(senders_that_no_force_tells_apart_are_mixed)
{
    for (int has_forces = 0; has_forces < 2; ++has_forces) {
        begin_log();
        for (int ms = 0; ms < 1000; ++ms) {
            add_pose(ms, HOLDER, ms + 1, 0);
            if (has_forces) {
                add_force(ms, HOLDER, ms + 1, 0, false);
            }
            if (ms >= 600 && ms < 700) {
                add_pose(ms, OTHER, ms, 0);
            }
        }
        play_log();
        assert_true(softsim_poses_is_mixed(poses));
        assert_int_equal(played.count, 1100);
        assert_int_equal(played.notes, 1);
        assert_non_null(strstr(played.note, "poses of two senders on probe 0 at byte "));
        softsim_poses_close(&poses);
    }
}

/* One after the other, as of a device that was started again, or each on a probe of its own. */
LOG_TEST(senders_one_after_the_other_are_not_mixed)
{
    begin_log();
    for (int ms = 0; ms < 1000; ++ms) {
        add_pose(ms, HOLDER, ms + 1, 0);
        add_pose(ms, THIRD, ms + 1, 1);
    }
    for (int ms = 1500; ms < 2000; ++ms) {
        add_pose(ms, OTHER, ms, 0);
    }
    play_log();
    assert_false(softsim_poses_is_mixed(poses));
    assert_int_equal(played.count, 2500);
    assert_int_equal(played.notes, 0);
}

/* A lockstep server's time is not the log's: the forces tell. */
LOG_TEST(senders_that_were_both_taken_are_not_mixed)
{
    begin_log();
    for (int i = 0; i < 200; ++i) {
        add_pose(i, i < 100 ? HOLDER : OTHER, i + 1, 0);
        add_force(i, i < 100 ? HOLDER : OTHER, i + 1, 0, false);
    }
    play_log();
    assert_false(softsim_poses_is_mixed(poses));
    assert_int_equal(played.count, 200);
}

/* One that held the probe, fell silent, and found another there. */
LOG_TEST(a_sender_that_lost_the_probe_is_played_until_then)
{
    begin_log();
    for (int ms = 0; ms < 3000; ++ms) {
        if (ms < 1000 || ms >= 2000) {
            add_pose(ms, HOLDER, ms + 1, 0);
        }
        if (ms < 1000 || (ms >= 2000 && ms % 100 == 0)) {
            add_force(ms, HOLDER, ms + 1, 0, ms >= 2000);
        }
        if (ms >= 1600) {
            add_pose(ms, OTHER, ms, 0);
            add_force(ms, OTHER, ms, 0, false);
        }
    }
    play_log();
    assert_false(softsim_poses_is_mixed(poses));
    assert_int_equal(played.of[0], 1000);
    assert_int_equal(played.of[1], 1400);
    assert_non_null(strstr(played.note, "left out 1000 poses"));
}

/* More senders, and more changes, than there is room for: in doubt, and nothing else. */
LOG_TEST(a_log_of_too_many_senders_is_mixed)
{
    begin_log();
    for (int i = 0; i < 9000; ++i) {
        add_force(i, HOLDER, i + 1, i % 8, i % 16 < 8);
        add_force(i, 1000 + i, i + 1, i % 8, false);
    }
    for (int i = 0; i < 100; ++i) {
        add_pose(i, i % 2 ? HOLDER : OTHER, i + 1, 0);
    }
    play_log();
    assert_true(softsim_poses_is_mixed(poses));
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
