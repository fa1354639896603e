/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A replay to the real daemon beside other senders, and to one that stands still for a while: it is
 * the log's, or it says why not.
 */
#include "common/test.h"

#include <signal.h>
#include <string.h>
#include <unistd.h>

#include "common/pose_fixture.h"
#include "daemon_fixture.h"
#include "softsim/status.h"
#include "softsim_probe_pose_t.h"

static void expect_exit(int expected)
{
    const int status = process_finish(&client);
    if (status != expected) {
        fail_msg("exit %d, not %d: %s%s", status, expected, client.out, client.err);
    }
}

/* Replay or bridge says `said`, once, and what it kept is not complete. */
static void expect_doubt(const char *said, const char *csv)
{
    expect_exit(1);
    const char *at = strstr(client.err, said);
    if (at == NULL) {
        fail_msg("no '%s' in: %s", said, client.err);
    }
    assert_null(strstr(at + 1, said));
    assert_int_equal(access(csv, F_OK), -1);
}

/* The bridge before has not let go: all of the log is played after it has. Where the machine let no
 * answer through for half a second, the log began without, was refused, and is played again. */
TEST_WITH(a_replay_waits_for_the_bridge_before, make_folder, tear_down)
{
    const char *const csv = in_folder("a.csv");
    const char *const bridge[] = {"softsim-bridge", "--device", "sim",       "--offset-m",
                                  "0,0,3",          "--csv",    "/dev/null", NULL};
    const char *const replay[] = {"softsim-replay", POKE, "--speed", "9", "--csv", csv, NULL};
    start_daemon(tube(), NULL);
    watch w;
    watch_open(&w);
    process_start(&other, bridge, NULL);
    while (w.forces == 0) {
        lcm_handle_timeout(w.lcm, 200);
    }
    watch_close(&w);
    process_start(&client, replay, NULL);
    for (int runs = 1; !process_wait_for(&client, "another sender holds probe 0; waits"); ++runs) {
        expect_exit(1);
        assert_true(runs < 20 && !process_has_ended(&other));
        process_start(&client, replay, NULL);
    }
    process_signal(&other, SIGINT);
    assert_int_equal(process_finish(&other), 0);
    expect_exit(0);
    assert_null(strstr(client.out, "refused"));
    assert_int_equal(access(csv, F_OK), 0);
    assert_int_equal(stop_daemon(), 0);
}

/* For two seconds, or from there on, the log goes where no server lets a tool: forces come all the
 * while, and answer the last pose before. */
TEST_WITH(a_part_of_a_log_that_is_refused_is_told, make_folder, tear_down)
{
    static const char *const said[] = {"no answer for ", "answers stopped at pose "};
    const char *const csv = in_folder("a.csv"), *const log = in_folder("far.csv");
    const char *const replay[] = {"softsim-replay", log, "--csv", csv, NULL};
    start_daemon(tube(), NULL);
    for (int i = 0; i < 2; ++i) {
        FILE *file = open_file("far.csv");
        fputs("time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,0,0,0,3,1,0,0,0,0\n"
              "0.5,0,0,0,3,1,0,0,0,0\n0.501,0,0,0,300,1,0,0,0,0\n2.5,0,0,0,300,1,0,0,0,0\n",
              file);
        if (i == 0) {
            fputs("2.501,0,0,0,3,1,0,0,0,0\n3,0,0,0,3,1,0,0,0,0\n", file);
        }
        fclose(file);
        process_start(&client, replay, NULL);
        expect_doubt(said[i], csv);
    }
    assert_int_equal(stop_daemon(), 0);
}

static void count_pose(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    (void)buffer, (void)channel;
    ++*(int *)user;
}

/* Poses of the replay, by one who listens, so many more. */
static void hear_poses(lcm_t *lcm, const int *poses, int more)
{
    const int wanted = *poses + more;
    while (*poses < wanted && !process_has_ended(&client)) {
        lcm_handle_timeout(lcm, 200);
    }
    assert_true(*poses >= wanted);
}

/* Two seconds of the log at its own speed, of which nothing is felt. Where the machine held the
 * replay back meanwhile, it has waited for less, and is played again. */
TEST_WITH(a_server_that_stood_still_is_told, make_folder, tear_down)
{
    const char *const csv = in_folder("a.csv");
    const char *const replay[] = {"softsim-replay", POKE, "--speed", "2", "--csv", csv, NULL};
    start_daemon(tube(), NULL);
    lcm_t *lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(lcm);
    int poses = 0;
    assert_non_null(lcm_subscribe(lcm, "SOFTSIM_PROBE_0", count_pose, &poses));
    for (int runs = 0; runs == 0 || client.status == 0; ++runs) {
        assert_true(runs < 20);
        process_start(&client, replay, NULL);
        hear_poses(lcm, &poses, 500);
        process_signal(&daemon_process, SIGSTOP);
        hear_poses(lcm, &poses, 4000);
        process_signal(&daemon_process, SIGCONT);
        process_finish(&client);
        if (client.status == 0) {
            unlink(csv);
        }
    }
    lcm_destroy(lcm);
    assert_int_equal(client.status, 1);
    assert_non_null(strstr(client.err, "no answer for "));
    assert_null(strstr(client.err, "has softsimd ended"));
    assert_int_equal(access(csv, F_OK), -1);
    assert_int_equal(stop_daemon(), 0);
}

/* Poses of a sender of one's own, until the replay has ended. */
static void send_beside(const char *channel, int probe)
{
    lcm_t *lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(lcm);
    for (int seq = 1; !process_has_ended(&client); ++seq) {
        const softsim_probe_pose_t pose = {
            .sender = 77, .seq = seq, .probe = probe, .position = {0.5, 0.5, 0.5}, PLAIN_POSE};
        softsim_probe_pose_t_publish(lcm, channel, &pose);
        lcm_handle_timeout(lcm, 1);
    }
    lcm_destroy(lcm);
}

/* In lockstep each of them is a tick, refused or not: on the log's own probe, and on another. */
TEST_WITH(ticks_of_others_are_told_by_a_lockstep_replay, make_folder, tear_down)
{
    const char *const lockstep[] = {"--lockstep", NULL};
    const char *const csv = in_folder("a.csv");
    const char *const replay[] = {"softsim-replay", POKE, "--lockstep", "--csv", csv, NULL};
    for (int probe = 0; probe < 2; ++probe) {
        start_daemon(tube(), lockstep);
        watch w;
        watch_open(&w);
        process_start(&client, replay, NULL);
        while (w.forces == 0 && !process_has_ended(&client)) {
            lcm_handle_timeout(w.lcm, 200);
        }
        watch_close(&w);
        send_beside(probe == 0 ? "SOFTSIM_PROBE_0" : "SOFTSIM_PROBE_1", probe);
        expect_doubt("poses of other senders made ", csv);
        assert_int_equal(stop_daemon(), 0);
    }
    /* Without them it is the log's. */
    start_daemon(tube(), lockstep);
    if (process_run(&client, replay) != 0) {
        fail_msg("replay: %s%s", client.out, client.err);
    }
    assert_null(strstr(client.err, "ticks"));
    assert_int_equal(stop_daemon(), 0);
}

/* Commands are no poses, be they none at all or too many to answer. */
TEST_WITH(refused_commands_are_no_ticks, make_folder, tear_down)
{
    static const uint8_t none[64];
    const softsim_command_t unknown = {.sender = 77, .id = 1, .name = "unknown", .argument = ""};
    const char *const lockstep[] = {"--lockstep", NULL};
    const char *const csv = in_folder("a.csv");
    const char *const replay[] = {"softsim-replay", POKE, "--lockstep", "--csv", csv, NULL};
    start_daemon(tube(), lockstep);
    lcm_t *lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(lcm);
    int poses = 0;
    assert_non_null(lcm_subscribe(lcm, "SOFTSIM_PROBE_0", count_pose, &poses));
    process_start(&client, replay, NULL);
    hear_poses(lcm, &poses, 200);
    for (int i = 0; i < 20; ++i) {
        lcm_publish(lcm, "SOFTSIM_COMMAND", none, sizeof none);
        lcm_publish(lcm, "SOFTSIM_COMMAND", none, 1);
        softsim_command_t_publish(lcm, "SOFTSIM_COMMAND", &unknown);
    }
    lcm_destroy(lcm);
    expect_exit(0);
    assert_null(strstr(client.err, "ticks"));
    assert_int_equal(stop_daemon(), 0);
}

/* In real time what is refused harms nobody. */
TEST_WITH(refused_poses_of_others_harm_no_paced_replay, make_folder, tear_down)
{
    const char *const csv = in_folder("a.csv");
    const char *const replay[] = {"softsim-replay", POKE, "--speed", "9", "--csv", csv, NULL};
    start_daemon(tube(), NULL);
    watch w;
    watch_open(&w);
    process_start(&client, replay, NULL);
    while (w.forces == 0 && !process_has_ended(&client)) {
        lcm_handle_timeout(w.lcm, 200);
    }
    watch_close(&w);
    send_beside("SOFTSIM_PROBE_0", 0);
    expect_exit(0);
    assert_int_equal(access(csv, F_OK), 0);
    assert_int_equal(stop_daemon(), 0);
}

static void command(const char *name)
{
    const char *const monitor[] = {"softsim-monitor", "--command", name, NULL};
    if (process_run(&other, monitor) != 0) {
        fail_msg("%s: %s%s", name, other.out, other.err);
    }
}

static bool is_running(const watch *w)
{
    return w->statuses > 0 && (w->status.fault_bits & SOFTSIM_STATUS_PAUSED) == 0;
}

/* And its statuses say so. */
static void resume(void)
{
    watch w;
    command("resume");
    watch_open(&w);
    watch_until(&w, is_running, "the end of the pause");
    watch_close(&w);
}

/* Its forces are zero, as of a tool in free space: from the first on, in real time and in lockstep,
 * or from the middle. */
TEST_WITH(a_paused_server_is_told_by_a_replay, make_folder, tear_down)
{
    const char *const lockstep[] = {"--lockstep", NULL};
    const char *const csv = in_folder("a.csv");
    const char *replay[] = {"softsim-replay", POKE, "--csv", csv, "--speed", "9", NULL};
    start_daemon(tube(), NULL);
    command("pause");
    process_start(&client, replay, NULL);
    expect_doubt("the server is paused from pose ", csv);
    assert_non_null(strstr(client.out, "peak 0 N"));
    resume();
    replay[4] = NULL; /* at its own speed */
    process_start(&client, replay, NULL);
    watch w;
    watch_open(&w);
    while (w.forces == 0) {
        lcm_handle_timeout(w.lcm, 200);
    }
    watch_close(&w);
    command("pause");
    expect_doubt("the server is paused from pose ", csv);
    resume();
    replay[4] = "--speed";
    process_start(&client, replay, NULL);
    expect_exit(0);
    assert_null(strstr(client.err, "paused"));
    assert_int_equal(stop_daemon(), 0);

    replay[4] = "--lockstep";
    replay[5] = NULL;
    unlink(csv);
    start_daemon(tube(), lockstep);
    command("pause");
    process_start(&client, replay, NULL);
    expect_doubt("the server is paused from pose 1 on; ", csv);
    assert_int_equal(stop_daemon(), 0);
}

/* It has touched nothing, and that is no fault of its place. */
TEST_WITH(a_paused_server_is_told_by_a_bridge, make_folder, tear_down)
{
    const char *const csv = in_folder("a.csv");
    const char *const bridge[] = {"softsim-bridge", "--device", "sim",   "--offset-m", "0,0,0.1",
                                  "--duration",     "1",        "--csv", csv,          NULL};
    start_daemon(tube(), NULL);
    command("pause");
    process_start(&client, bridge, NULL);
    expect_doubt("the server is paused ", csv);
    assert_null(strstr(client.err, "touched nothing"));
    assert_non_null(strstr(client.out, "halt        the server is paused from pose "));
    assert_int_equal(stop_daemon(), 0);
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
