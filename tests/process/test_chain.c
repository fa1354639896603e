/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The whole chain: the real daemon, real clients, real LCM on a private loopback.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <arpa/inet.h>
#include <cmocka.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <lcm/lcm.h>
#include <poll.h>
#include <time.h>

#include "../folder_fixture.h"
#include "process.h"
#include "softsim/types.h"
#include "softsim_command_t.h"
#include "softsim_contact_force_t.h"
#include "softsim_mesh_topology_t.h"
#include "softsim_reply_t.h"
#include "softsim_server_status_t.h"

#define SCENES SOURCE_DIR "/server/scenes/"
#define KIDNEY SCENES "kidney.yaml"
#define POKE   SCENES "kidney-poke.lcmlog"

static process daemon_process, client, other;

static int tear_down(void **state)
{
    process *all[] = {&client, &other, &daemon_process};
    for (int i = 0; i < 3; ++i) {
        process_signal(all[i], SIGKILL);
        process_finish(all[i]);
    }
    return remove_folder(state);
}

static void start_daemon(const char *const *extra)
{
    const char *argv[24] = {"softsimd", KIDNEY};
    int count = 2;
    while (extra && *extra) {
        argv[count++] = *extra++;
    }
    process_start(&daemon_process, argv, NULL);
    if (!process_wait_for(&daemon_process, "softsimd: ready")) {
        fail_msg("no ready line; stderr: %s", daemon_process.err);
    }
}

static int stop_daemon(void)
{
    process_signal(&daemon_process, SIGTERM);
    const int status = process_finish(&daemon_process);
    if (status != 0) {
        print_error("softsimd: %s", daemon_process.err);
    }
    return status;
}

/* ---- a replay's CSV
 * ------------------------------------------------------------------------------- */

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
                        "model_age_us,flags,latency_us\n");
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

static double magnitude(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

enum { ROWS = 20000 };
static row rows[ROWS];

static void feels_the_kidney(void **state)
{
    (void)state;
    const char *csv = in_folder("out.csv");
    start_daemon(NULL);
    const char *const replay[] = {"softsim-replay", POKE, "--csv", csv, NULL};
    if (process_run(&client, replay) != 0) {
        fail_msg("replay: %s%s", client.out, client.err);
    }
    assert_int_equal(stop_daemon(), 0);

    const int count = read_csv(csv, rows, ROWS);
    assert_true(count > 7000);
    double peak = 0.0;
    int touching = 0;
    for (int i = 0; i < count; ++i) {
        const double f = magnitude(rows[i].force);
        assert_true(isfinite(f));
        peak = fmax(peak, f);
        touching += (rows[i].flags & SOFTSIM_FORCE_CONTACT) != 0;
        if (!(rows[i].flags &
              (SOFTSIM_FORCE_CONTACT | SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_LIMITED))) {
            assert_true(f == 0.0);
        }
    }
    if (!(peak > 0.5 && peak <= 8.0 * (1.0 + 1e-14))) { /* the limit, and a norm's rounding */
        fail_msg("the largest force is %.17g N", peak);
    }
    assert_true(touching > 1000 && touching < count - 500);
    assert_true(magnitude(rows[count - 1].force) == 0.0);
}

/* ---- lockstep
 * ----------------------------------------------------------------------------------------- */

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

/* The first `records` of the probe log, 191 bytes each: sanitizers are slow. */
static const char *shorter_log(size_t records)
{
    static char data[191 * 9000];
    FILE *from = fopen(POKE, "rb");
    assert_non_null(from);
    const size_t size = fread(data, 191, records, from);
    fclose(from);
    const char *path = in_folder("short.lcmlog");
    FILE *to = fopen(path, "wb");
    assert_non_null(to);
    assert_int_equal(fwrite(data, 191, size, to), records);
    fclose(to);
    return path;
}

static void replays_bit_for_bit(void **state)
{
    (void)state;
    char hash[4][64];
    char log[320];
    snprintf(log, sizeof log, "%s", shorter_log(LOCKSTEP_RECORDS));
    static const char *const threads[] = {"1", "1", "2"};
    for (int i = 0; i < 3; ++i) {
        const char *const run[] = {"softsim-run", KIDNEY,     "--poses", log,
                                   "--threads",   threads[i], "--hash",  NULL};
        if (process_run(&client, run) != 0) {
            fail_msg("softsim-run: %s", client.err);
        }
        last_line(client.out, hash[i], sizeof hash[i]);
        assert_int_equal(strlen(hash[i]), 16);
    }
    const char *const lockstep[] = {"--lockstep", "--hash", NULL};
    start_daemon(lockstep);
    const char *const replay[] = {"softsim-replay", log, "--lockstep", NULL};
    if (process_run(&client, replay) != 0) {
        fail_msg("replay: %s%s", client.out, client.err);
    }
    assert_int_equal(stop_daemon(), 0);
    last_line(daemon_process.out, hash[3], sizeof hash[3]);
    for (int i = 1; i < 4; ++i) {
        assert_string_equal(hash[0], hash[i]);
    }
}

/* ---- what a test client sees
 * -------------------------------------------------------------------------- */

typedef struct watch {
    lcm_t *lcm;
    softsim_contact_force_t_subscription_t *force_subscription;
    softsim_server_status_t_subscription_t *status_subscription;
    softsim_reply_t_subscription_t *reply_subscription;
    softsim_contact_force_t force;
    int forces;
    softsim_server_status_t status;
    int statuses;
    int reply_code, replies;
    int32_t old_seq;     /* seq of the last force before the last new pose was answered */
    int32_t fresh_seq;   /* seq of the first force that answered it */
    int32_t fresh_flags; /* of the forces since, but for those that say stale */
    int32_t felt_seq;    /* seq of the last force that was not zero */
    int32_t zero_seq;    /* seq of the first zero force after them */
    char reason[256], reply[256];
} watch;

static void on_force(const lcm_recv_buf_t *buffer, const char *channel,
                     const softsim_contact_force_t *message, void *user)
{
    watch *w = user;
    (void)buffer, (void)channel;
    if (message->pose_seq != w->force.pose_seq) {
        w->old_seq = w->force.seq;
        w->fresh_seq = message->seq;
        w->fresh_flags = 0;
        w->zero_seq = 0;
    }
    if ((message->flags & SOFTSIM_FORCE_STALE) == 0) {
        w->fresh_flags |= message->flags;
    }
    if (magnitude(message->force) > 0.0) {
        w->felt_seq = message->seq;
        w->zero_seq = 0;
    } else if (w->zero_seq == 0) {
        w->zero_seq = message->seq;
    }
    w->force = *message;
    ++w->forces;
}

static void on_status(const lcm_recv_buf_t *buffer, const char *channel,
                      const softsim_server_status_t *message, void *user)
{
    watch *w = user;
    (void)buffer, (void)channel;
    w->status = *message;
    snprintf(w->reason, sizeof w->reason, "%s", message->reason);
    ++w->statuses;
}

static void on_reply(const lcm_recv_buf_t *buffer, const char *channel,
                     const softsim_reply_t *message, void *user)
{
    watch *w = user;
    (void)buffer, (void)channel;
    w->reply_code = message->code;
    snprintf(w->reply, sizeof w->reply, "%s", message->text);
    ++w->replies;
}

static void watch_open(watch *w)
{
    memset(w, 0, sizeof *w);
    w->lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(w->lcm);
    w->force_subscription =
        softsim_contact_force_t_subscribe(w->lcm, "SOFTSIM_FORCE_0", on_force, w);
    w->status_subscription =
        softsim_server_status_t_subscribe(w->lcm, "SOFTSIM_STATUS", on_status, w);
    w->reply_subscription = softsim_reply_t_subscribe(w->lcm, "SOFTSIM_REPLY", on_reply, w);
}

static void watch_close(watch *w)
{
    softsim_contact_force_t_unsubscribe(w->lcm, w->force_subscription);
    softsim_server_status_t_unsubscribe(w->lcm, w->status_subscription);
    softsim_reply_t_unsubscribe(w->lcm, w->reply_subscription);
    lcm_destroy(w->lcm);
}

/* Handles messages until `done` says so; fails after 20 s. */
static void watch_until(watch *w, bool (*done)(const watch *w), const char *what)
{
    struct timespec start, now;
    clock_gettime(CLOCK_MONOTONIC, &start);
    while (!done(w)) {
        lcm_handle_timeout(w->lcm, 200);
        clock_gettime(CLOCK_MONOTONIC, &now);
        if (now.tv_sec - start.tv_sec > 20) {
            fail_msg("waited 20 s for %s; daemon: %s", what, daemon_process.err);
        }
    }
}

static void send_command(watch *w, int id, char *name, char *argument)
{
    const softsim_command_t command = {.sender = 7, .id = id, .name = name, .argument = argument};
    softsim_command_t_publish(w->lcm, "SOFTSIM_COMMAND", &command);
}

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

static bool says_silent(const watch *w)
{
    return strstr(w->reason, "silent") != NULL;
}

static bool says_more(const watch *w)
{
    return w->statuses >= 2;
}

static bool says_nothing(const watch *w)
{
    return w->reason[0] == '\0';
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
 * machine that is held back had the hand let in anew meanwhile, that may come to feel nothing
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
    const bool was_in =
        w->felt_seq >= w->fresh_seq && (w->fresh_flags & SOFTSIM_FORCE_RAMPING) == 0;
    if (w->felt_seq - w->fresh_seq > 69 || (was_in && w->zero_seq - w->old_seq + skipped < 70)) {
        fail_msg("the pose of force %d (%d before, flags %d) was felt up to force %d, zero from "
                 "%d, %d ticks missed",
                 w->fresh_seq, w->old_seq, w->fresh_flags, w->felt_seq, w->zero_seq, (int)skipped);
    }
}

static void silent_bridge_is_let_go(void **state)
{
    (void)state;
    watch w;
    start_daemon(NULL);
    watch_open(&w);
    start_bridge("slide");
    press_and_fall_silent(&w, SIGSTOP);
    process_signal(&client, SIGCONT);
    press_and_fall_silent(&w, SIGKILL);
    process_finish(&client);
    watch_until(&w, says_silent, "a status that says why");
    watch_until(&w, says_nothing, "statuses that no longer do");
    watch_close(&w);
    assert_int_equal(stop_daemon(), 0);
}

static void replay_outlives_a_killed_daemon(void **state)
{
    (void)state;
    start_daemon(NULL);
    /* More often than ever needed: a daemon may take long to start on a busy machine. */
    const char *const replay[] = {"softsim-replay", POKE, "--repeat", "50", NULL};
    process_start(&client, replay, NULL);
    watch w;
    watch_open(&w);
    watch_until(&w, is_pressed, "a force");
    process_signal(&daemon_process, SIGKILL);
    process_finish(&daemon_process);
    start_daemon(NULL);
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

static bool has_reply(const watch *w)
{
    return w->replies > 0;
}

static void expect_reply(watch *w, char *name, char *argument, int code)
{
    w->replies = 0;
    send_command(w, 1, name, argument);
    watch_until(w, has_reply, name);
    if (w->reply_code != code) {
        fail_msg("%s %s: code %d, text %s", name, argument, w->reply_code, w->reply);
    }
}

static void obeys_commands(void **state)
{
    (void)state;
    watch w;
    start_daemon(NULL);
    watch_open(&w);
    expect_reply(&w, "pause", "", 0);
    expect_reply(&w, "resume", "", 0);
    expect_reply(&w, "reset", "", 0);
    expect_reply(&w, "refresh", "", 0);
    expect_reply(&w, "status", "", 0);
    expect_reply(&w, "set", "haptic.max_force_n=3", 0);
    expect_reply(&w, "set", "haptic.max_force_n=-3", 2);
    expect_reply(&w, "set", "object.mesh=other.obj", 2);
    expect_reply(&w, "dance", "", 2);
    expect_reply(&w, "shutdown", "", 0);
    assert_int_equal(process_finish(&daemon_process), 0);

    const char *const closed[] = {"--no-commands", NULL};
    start_daemon(closed);
    expect_reply(&w, "status", "", 0);
    expect_reply(&w, "shutdown", "", 1);
    watch_close(&w);
    assert_int_equal(stop_daemon(), 0);
}

/* ---- the topology ------------------------------------------------------------------------------
 */

enum { GRID_ROWS = 15, GRID_COLUMNS = 24, GRID_NODES = GRID_ROWS * GRID_COLUMNS };

typedef struct topology {
    int node_count;
    int seen[GRID_NODES]; /* by the file's number */
    int moved;            /* nodes whose number on the wire is another */
    double worst;         /* m, from where that node of the file lies */
    int wrong_flags;
} topology;

static void on_topology(const lcm_recv_buf_t *buffer, const char *channel,
                        const softsim_mesh_topology_t *m, void *user)
{
    (void)buffer;
    (void)channel;
    topology *t = user;
    t->node_count = m->node_count;
    for (int k = 0; k < m->node_chunk; ++k) {
        const int file = m->file_node[k];
        if (file < 0 || file >= GRID_NODES) {
            t->worst = INFINITY;
            return;
        }
        const int ring = file / GRID_COLUMNS;
        const double phi = 2.0 * 3.14159265358979323846 * (file % GRID_COLUMNS) / GRID_COLUMNS;
        const double x[3] = {cos(phi), sin(phi), 4.0 * ring / (GRID_ROWS - 1) - 2.0};
        for (int axis = 0; axis < 3; ++axis) {
            t->worst = fmax(t->worst, fabs((double)m->rest[3 * k + axis] - x[axis]));
        }
        t->seen[file] = 1;
        t->moved += file != m->first_node + k;
        t->wrong_flags += (m->node_flag[k] & 1) != (ring == 0 || ring == GRID_ROWS - 1);
    }
}

/* The body is numbered by place inside; on the wire each node says its number in the file. */
static void the_topology_leads_back_to_the_files_numbers(void **state)
{
    (void)state;
    const char *const argv[] = {"softsimd", SCENES "cylinder-grid.yaml", NULL};
    topology t = {0};
    lcm_t *lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(lcm);
    softsim_mesh_topology_t_subscription_t *subscription =
        softsim_mesh_topology_t_subscribe(lcm, "SOFTSIM_MESH_TOPOLOGY", on_topology, &t);
    process_start(&daemon_process, argv, NULL);
    assert_true(process_wait_for(&daemon_process, "softsimd: ready"));
    int seen = 0;
    for (int tries = 0; tries < 100 && seen < GRID_NODES; ++tries) {
        lcm_handle_timeout(lcm, 200);
        seen = 0;
        for (int i = 0; i < GRID_NODES; ++i) {
            seen += t.seen[i];
        }
    }
    softsim_mesh_topology_t_unsubscribe(lcm, subscription);
    lcm_destroy(lcm);
    assert_int_equal(stop_daemon(), 0);
    assert_int_equal(t.node_count, GRID_NODES);
    assert_int_equal(seen, GRID_NODES);
    assert_true(t.worst < 1e-6);
    assert_true(t.moved > GRID_NODES / 2);
    assert_int_equal(t.wrong_flags, 0);
}

static void monitor_sends_commands(void **state)
{
    (void)state;
    static const struct {
        const char *command, *said;
        int status;
    } cases[] = {{"pause", "done\n", 0},
                 {"resume", "done\n", 0},
                 {"set haptic.max_force_n=5", "done\n", 0},
                 {"set haptic.max_force_n=-5", "haptic.max_force_n is -5", 2},
                 {"dance", "unknown command 'dance'", 2}};
    start_daemon(NULL);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const char *const argv[] = {"softsim-monitor", "--command", cases[i].command, NULL};
        const int status = process_run(&client, argv);
        if (status != cases[i].status || !strstr(client.out, cases[i].said)) {
            fail_msg("%s: %d: %s%s", cases[i].command, status, client.out, client.err);
        }
    }
    /* A pose for a probe that the scene has no tool for: the status knows why nothing answers. */
    const char *const bridge[] = {"softsim-bridge", "--device", "sim", "--probe", "5",
                                  "--ticks",        "50",       NULL};
    assert_int_equal(process_run(&client, bridge), 1);
    assert_non_null(strstr(client.err, "(wrong probe); has its scene a tool for probe 5"));
    assert_int_equal(stop_daemon(), 0);

    const char *const closed[] = {"--no-commands", NULL};
    const char *const argv[] = {"softsim-monitor", "--command", "pause", NULL};
    start_daemon(closed);
    assert_int_equal(process_run(&client, argv), 1);
    assert_non_null(strstr(client.out, "refused"));
    assert_int_equal(stop_daemon(), 0);
}

/* ---- what the server says of itself
 * ------------------------------------------------------------------------------------------ */

static bool is_warm(const watch *w)
{
    return w->statuses > 0 && w->status.uptime_s > 1.0;
}

static bool is_later(const watch *w)
{
    return w->status.uptime_s > 2.2;
}

/* So light and so stiff that a quarter of a millisecond takes some dozens of sub-steps. */
static void a_slow_server_says_so(void **state)
{
    (void)state;
    const char *const slow[] = {
        "--set", "haptic.rate_hz=4000",           "--set", "simulation.rate_hz=4000",
        "--set", "model.area_density_kg_m2=1e-6", "--set", "model.damping_n_s_per_m3=1",
        "--set", "simulation.max_substeps=1000",  NULL};
    watch w;
    start_daemon(slow);
    watch_open(&w);
    watch_until(&w, is_warm, "a status");
    const softsim_server_status_t first = w.status;
    watch_until(&w, is_later, "a status");
    const double done = (double)(w.status.step - first.step) / (w.status.uptime_s - first.uptime_s);
    print_message("%.0f steps a second, said to be %.0f\n", done, w.status.simulation_rate_hz);
    assert_true(w.status.simulation_rate_hz < 3000.0);
    assert_true(fabs(w.status.simulation_rate_hz / done - 1.0) < 0.3);
    assert_int_equal(w.status.verdict, SOFTSIM_VERDICT_DEGRADED);
    assert_non_null(strstr(w.reason, "slower than real time"));
    assert_non_null(strstr(w.reason, "of 4000 steps a second"));
    watch_close(&w);
    assert_int_equal(stop_daemon(), 0);
    const char *said = strstr(daemon_process.err, "warning: degraded: the simulation is slower");
    assert_non_null(said);
    assert_null(strstr(said + 1, "warning: degraded")); /* once */
}

static void two_servers_on_one_prefix_are_told(void **state)
{
    (void)state;
    const char *const elsewhere[] = {"softsimd", KIDNEY, "--prefix", "ELSEWHERE", NULL};
    start_daemon(NULL);
    process_start(&other, elsewhere, NULL);
    assert_true(process_wait_for(&other, "softsimd: ready"));
    const char *const watching[] = {"softsim-monitor", "--duration", "1", NULL};
    assert_int_equal(process_run(&client, watching), 0);
    process_signal(&other, SIGTERM);
    assert_int_equal(process_finish(&other), 0);
    assert_null(strstr(other.err, "another server"));
    const char *const here[] = {"softsimd", KIDNEY, NULL};
    process_start(&other, here, NULL);
    assert_true(process_wait_for(&other, "another server answers on prefix SOFTSIM"));
    assert_true(process_wait_for(&daemon_process, "another server answers on prefix SOFTSIM"));
    process_signal(&other, SIGTERM);
    assert_int_equal(process_finish(&other), 0);
    assert_int_equal(stop_daemon(), 0);
}

static void monitor_prints_one_status(void **state)
{
    (void)state;
    start_daemon(NULL);
    const char *const monitor[] = {"softsim-monitor", "--once", "--json", NULL};
    assert_int_equal(process_run(&client, monitor), 0);
    assert_non_null(strstr(client.out, "\"model\": \"cnn-energy\""));
    assert_non_null(strstr(client.out, "\"verdict\""));
    assert_int_equal(stop_daemon(), 0);
}

/* ---- packets
 * ------------------------------------------------------------------------------------------- */

/* A fragment whose offset and size wrap in 32 bits, as LCM adds them. */
static void send_wrapping_fragment(int fd)
{
    static const uint8_t packet[] = "LC03\0\0\0\1\0\0\0\144\xff\xff\xff\xf0\0\0\0\1"
                                    "SOFTSIM_PROBE_0\0........................................";
    const struct sockaddr_in group = {.sin_family = AF_INET,
                                      .sin_port = htons(7667),
                                      .sin_addr.s_addr = inet_addr("239.255.76.67")};
    assert_int_equal(
        sendto(fd, packet, sizeof packet - 1, 0, (const struct sockaddr *)&group, sizeof group),
        sizeof packet - 1);
}

static void no_fragment_crashes_server_or_client(void **state)
{
    (void)state;
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    assert_true(fd >= 0);
    start_daemon(NULL);
    const char *const monitor[] = {"softsim-monitor", NULL};
    process_start(&client, monitor, NULL);
    assert_true(process_wait_for(&client, "step"));
    for (int i = 0; i < 20; ++i) {
        send_wrapping_fragment(fd);
    }
    close(fd);
    /* Both still talk: a status that was sent after the fragments. */
    const char *const once[] = {"softsim-monitor", "--once", "--json", NULL};
    assert_int_equal(process_run(&other, once), 0);
    process_signal(&client, SIGINT);
    assert_int_equal(process_finish(&client), 0);
    assert_int_equal(stop_daemon(), 0);
}

int main(void)
{
    if (!process_isolate()) {
        fprintf(stderr, "skipped: no private network namespace allowed here\n");
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(feels_the_kidney, make_folder, tear_down),
        cmocka_unit_test_setup_teardown(replays_bit_for_bit, make_folder, tear_down),
        cmocka_unit_test_setup_teardown(silent_bridge_is_let_go, make_folder, tear_down),
        cmocka_unit_test_setup_teardown(replay_outlives_a_killed_daemon, make_folder, tear_down),
        cmocka_unit_test_setup_teardown(obeys_commands, make_folder, tear_down),
        cmocka_unit_test_setup_teardown(the_topology_leads_back_to_the_files_numbers, make_folder,
                                        tear_down),
        cmocka_unit_test_setup_teardown(monitor_sends_commands, make_folder, tear_down),
        cmocka_unit_test_setup_teardown(a_slow_server_says_so, make_folder, tear_down),
        cmocka_unit_test_setup_teardown(two_servers_on_one_prefix_are_told, make_folder, tear_down),
        cmocka_unit_test_setup_teardown(monitor_prints_one_status, make_folder, tear_down),
        cmocka_unit_test_setup_teardown(no_fragment_crashes_server_or_client, make_folder,
                                        tear_down),
    };
    return cmocka_run_group_tests_name("chain", tests, NULL, NULL);
}
