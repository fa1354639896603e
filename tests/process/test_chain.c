/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The whole chain: the real daemon, real clients, real LCM on a private loopback.
 */
#include "common/test.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/effort.h"
#include "daemon_fixture.h"

/* ---- a replay's CSV ---- */

typedef struct row {
    long pose_seq;
    double force[3], depth;
    int flags;
} row;

static int read_csv(const char *path, row *rows, int capacity)
{
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    char line[1024];
    int count = 0;
    assert_non_null(fgets(line, sizeof line, file));
    assert_string_equal(line,
                        "pose_seq,pose_utime,probe,fx,fy,fz,tx,ty,tz,depth_m,stiffness_n_per_m,"
                        "model_age_us,flags,latency_us,indentation_m\n");
    while (count < capacity && fgets(line, sizeof line, file)) {
        row *r = &rows[count++];
        double unused[8];
        assert_int_equal(sscanf(line, "%ld,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%d",
                                &r->pose_seq, &unused[0], &unused[1], &r->force[0], &r->force[1],
                                &r->force[2], &unused[2], &unused[3], &unused[4], &r->depth,
                                &unused[5], &unused[6], &r->flags),
                         13);
    }
    fclose(file);
    return count;
}

enum { ROWS = 20000 };
static row rows[ROWS];

/* The probe log played once, in a long run as slowly as it was recorded; true when its press was
 * felt. Whatever the machine does meanwhile, every force is one that may be given to a hand. */
static bool play_and_feel(int *out_count)
{
    const char *csv = in_folder("out.csv");
    const char *const replay[] = {"softsim-replay",           POKE, "--csv", csv, "--speed",
                                  FULL_IN_LONG_RUN("1", "2"), NULL};
    if (process_run(&client, replay) != 0) {
        fail_msg("replay: %s%s", client.out, client.err);
    }
    const int count = *out_count = read_csv(csv, rows, ROWS);
    double peak = 0.0;
    int touching = 0, free = 0;
    for (int i = 0; i < count; ++i) {
        const double f = magnitude(rows[i].force);
        assert_true(isfinite(f));
        peak = fmax(peak, f);
        touching += (rows[i].flags & SOFTSIM_FORCE_CONTACT) != 0;
        if (!(rows[i].flags &
              (SOFTSIM_FORCE_CONTACT | SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_LIMITED))) {
            assert_true(f == 0.0);
            ++free;
        }
    }
    if (!(peak <= 8.0 * (1.0 + 1e-14))) { /* the limit, and a norm's rounding */
        fail_msg("the largest force is %.17g N", peak);
    }
    print_message("%d forces, %d touching, peak %.3f N\n", count, touching, peak);
    return peak > 0.5 && touching > 100 && free > 100 && magnitude(rows[count - 1].force) == 0.0;
}

/* Poses that come late are refused, by the contract: on a machine that holds the replay back the
 * press may be felt only when it is played again. */
TEST_WITH(feels_the_kidney, make_folder, tear_down)
{
    SKIP_WHERE_REPEATED();
    start_kidney();
    int rows_of_play = 0, row_count = 0, plays = 0;
    bool is_felt = false;
    for (; !is_felt; ++plays) {
        assert_true(plays < 20);
        is_felt = play_and_feel(&rows_of_play);
        row_count += rows_of_play;
    }
    assert_int_equal(stop_daemon(), 0);
    /* Each tick was a force or is counted as missed, though a late one was sent; none is told
     * twice. */
    long periods = 0, forces = 0, missed = 0;
    const char *said = strstr(daemon_process.err, " haptic periods: ");
    assert_non_null(said);
    while (said > daemon_process.err && said[-1] >= '0' && said[-1] <= '9') {
        --said;
    }
    assert_int_equal(
        sscanf(said, "%ld haptic periods: %ld forces, %ld missed", &periods, &forces, &missed), 3);
    assert_int_equal(forces + missed, periods);
    assert_in_range(row_count, 1, periods);
}

/* ---- lockstep ---- */

static void last_line(const char *text, char *out, size_t size)
{
    size_t end = strlen(text);
    while (end > 0 && text[end - 1] == '\n') {
        --end;
    }
    size_t begin = end;
    while (begin > 0 && text[begin - 1] != '\n') {
        --begin;
    }
    snprintf(out, size, "%.*s", (int)(end - begin), text + begin);
}

/* `count` records of the probe log from number `first` on, 191 bytes each. */
static const char *cut_log(long first, size_t count)
{
    static char data[191 * 9000];
    FILE *from = fopen(POKE, "rb");
    assert_non_null(from);
    assert_int_equal(fseek(from, 191 * first, SEEK_SET), 0);
    const size_t size = fread(data, 191, count, from);
    fclose(from);
    const char *path = in_folder("short.lcmlog");
    FILE *to = fopen(path, "wb");
    assert_non_null(to);
    assert_int_equal(fwrite(data, 191, size, to), count);
    fclose(to);
    return path;
}

TEST_WITH(replays_bit_for_bit, make_folder, tear_down)
{
    SKIP_WHERE_REPEATED();
    char hash[3][64];
    char log[320];
    /* The tool touches at record 1550 and has pressed 2 N at 2100. */
    snprintf(log, sizeof log, "%s",
             cut_log(FULL_IN_LONG_RUN(0, 1450), FULL_IN_LONG_RUN(9000, 1000)));
    static const char *const threads[] = {"1", "2"};
    for (int i = 0; i < 2; ++i) {
        const char *const run[] = {"softsim-run", KIDNEY,      "--set",    kidney_mesh(), "--poses",
                                   log,           "--threads", threads[i], "--hash",      NULL};
        if (process_run(&client, run) != 0) {
            fail_msg("softsim-run: %s", client.err);
        }
        last_line(client.out, hash[i], sizeof hash[i]);
        assert_int_equal(strlen(hash[i]), 16);
    }
    const char *const lockstep[] = {"--set", kidney_mesh(), "--lockstep", "--hash", NULL};
    start_daemon(KIDNEY, lockstep);
    const char *const replay[] = {"softsim-replay", log, "--lockstep", NULL};
    if (process_run(&client, replay) != 0) {
        fail_msg("replay: %s%s", client.out, client.err);
    }
    assert_int_equal(stop_daemon(), 0);
    last_line(daemon_process.out, hash[2], sizeof hash[2]);
    for (int i = 1; i < 3; ++i) {
        assert_string_equal(hash[0], hash[i]);
    }
}

/* ---- silence and death ---- */

/* Not while it is let in, nor let go. */
static bool is_pressed(const watch *w)
{
    return w->forces > 0 && magnitude(w->force.force) > 0.3 &&
           (w->force.flags & (SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_STALE)) == 0;
}

/* Zero because nobody speaks: a hand that comes back after a silence starts from zero as well. */
static bool is_released(const watch *w)
{
    return w->zero_seq != 0 && (w->force.flags & SOFTSIM_FORCE_STALE) != 0;
}

/* A server that is slower than real time, as under the thread sanitizer, says that first. */
static bool says_silent(const watch *w)
{
    return strstr(w->reason, "silent") != NULL || strstr(w->reason, "real time") != NULL;
}

static bool says_more(const watch *w)
{
    return w->statuses >= 2;
}

static bool says_no_more(const watch *w)
{
    return strstr(w->reason, "silent") == NULL;
}

static void start_bridge(const char *script)
{
    char command[512] = "";
    FILE *file = fopen(SCENES "kidney-poke.sh", "r");
    assert_non_null(file);
    char line[512];
    while (fgets(line, sizeof line, file)) {
        if (sscanf(line, "KIDNEY_BRIDGE=\"%511[^\"]\"", command) == 1) {
            break;
        }
    }
    fclose(file);
    assert_true(*command);
    const char *argv[32] = {"softsim-bridge", "--device", "sim", "--script", script};
    int count = 5;
    for (char *word = strtok(command, " "); word && count < 31; word = strtok(NULL, " ")) {
        argv[count++] = word;
    }
    process_start(&client, argv, NULL);
}

/* Presses, then has the bridge fall silent by `signal`: 50 ticks without a pose, then 20 of ramp. A
 * force counts ticks that were run, `probe_missed` those that were not. A message may be lost on
 * its way here: the last pose was answered after old_seq and at fresh_seq at the latest. Where a
 * machine that is held back had the hand let in again meanwhile, that may come to feel nothing
 * sooner. */
static void press_and_fall_silent(watch *w, int signal)
{
    w->statuses = 0;
    watch_until(w, says_more, "a status");
    const int64_t missed = w->status.probe_missed[0];
    watch_until(w, is_pressed, "a force");
    process_signal(&client, signal);
    w->reason[0] = '\0';
    watch_until(w, is_released, "the release");
    w->statuses = 0;
    watch_until(w, says_more, "a status");
    const int64_t skipped = w->status.probe_missed[0] - missed;
    /* A hand may have stopped as it bounced off: what fades by itself needs no ramp. */
    const bool was_in = w->felt_seq >= w->fresh_seq && w->fresh_force > 0.01 &&
                        (w->fresh_flags & SOFTSIM_FORCE_RAMPING) == 0;
    if (w->felt_seq - w->fresh_seq > 69 || (was_in && w->zero_seq - w->old_seq + skipped < 70)) {
        fail_msg("the pose of force %d (%d before, flags %d) was felt up to force %d, zero from "
                 "%d, %d ticks missed",
                 w->fresh_seq, w->old_seq, w->fresh_flags, w->felt_seq, w->zero_seq, (int)skipped);
    }
}

TEST_WITH(silent_bridge_is_let_go, make_folder, tear_down)
{
    watch w;
    start_kidney();
    watch_open(&w);
    start_bridge("slide");
    press_and_fall_silent(&w, SIGSTOP);
    process_signal(&client, SIGCONT);
    press_and_fall_silent(&w, SIGKILL);
    process_finish(&client);
    watch_until(&w, says_silent, "a status that says why");
    w.statuses = 0;
    watch_until(&w, says_more, "a status");
    watch_until(&w, says_no_more, "statuses that no longer do");
    watch_close(&w);
    assert_int_equal(stop_daemon(), 0);
}

static void count_pose(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    (void)buffer, (void)channel;
    ++*(int *)user;
}

/* Taps behind a bus of 10 ms, whose correction would take them to 4.9 N: the device is told no more
 * than the server's limit, which it has from the scene's report. */
TEST_WITH(a_bridge_stays_within_the_limit_that_was_set, make_folder, tear_down)
{
    static const char lower[] = "set haptic.max_force_n=1";
    const char *csv = in_folder("tap.csv");
    const char *const set[] = {"softsim-monitor", "--command", lower, NULL};
    const char *const tap[] = {
        "softsim-bridge", "--device", "sim",   "--script", "tap", "--delay-ms", "10",
        "--ticks",        "3000",     "--csv", csv,        NULL};
    start_kidney();
    assert_int_equal(process_run(&client, set), 0);
    assert_int_equal(process_run(&client, tap), 0);
    assert_int_equal(stop_daemon(), 0);
    FILE *file = fopen(csv, "r");
    assert_non_null(file);
    char line[1024];
    double f[3], most = 0.0;
    while (fgets(line, sizeof line, file)) {
        if (sscanf(line, "%*d,%*f,%*f,%*f,%*f,%*f,%*f,%*f,%*f,%*f,%lf,%lf,%lf", &f[0], &f[1],
                   &f[2]) == 3) {
            most = fmax(most, sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]));
        }
    }
    fclose(file);
    assert_true(most > 0.5 && most <= 1.0 + 1e-9);
}

/* It speaks on to nobody, and is answered again by the next server. How long that takes to start is
 * the machine's affair, and 5 s without an answer end a replay: it is held meanwhile. */
TEST_WITH(replay_outlives_a_killed_daemon, make_folder, tear_down)
{
    start_kidney();
    /* More often than ever needed: what is felt of it may take long on a busy machine. */
    const char *const replay[] = {"softsim-replay", POKE, "--repeat", "200", NULL};
    process_start(&client, replay, NULL);
    watch w;
    watch_open(&w);
    watch_until(&w, is_pressed, "a force");
    process_signal(&daemon_process, SIGKILL);
    process_finish(&daemon_process);
    int poses = 0;
    lcm_subscription_t *heard = lcm_subscribe(w.lcm, "SOFTSIM_PROBE_0", count_pose, &poses);
    while (poses < 300 && !process_has_ended(&client)) {
        lcm_handle_timeout(w.lcm, 200);
    }
    lcm_unsubscribe(w.lcm, heard);
    process_signal(&client, SIGSTOP);
    start_kidney();
    process_signal(&client, SIGCONT);
    w.force.force[0] = w.force.force[1] = w.force.force[2] = 0.0;
    watch_until(&w, is_pressed, "a force of the new daemon");
    watch_close(&w);
    process_signal(&client, SIGINT);
    process_finish(&client);
    if (strstr(client.err, "stopped after") == NULL) {
        fail_msg("replay: %s%s", client.out, client.err);
    }
    assert_int_equal(stop_daemon(), 0);
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
