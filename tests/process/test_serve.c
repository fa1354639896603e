/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What the real daemon says to those who ask or watch: commands, topology, status, and packets that
 * are not its own.
 */

#include "common/test.h"

#include <arpa/inet.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <poll.h>

#include "daemon_fixture.h"
#include "rt/vec.h"
#include "softsim_mesh_topology_t.h"

static void send_command(watch *w, int id, char *name, char *argument)
{
    const softsim_command_t command = {.sender = 7, .id = id, .name = name, .argument = argument};
    softsim_command_t_publish(w->lcm, "SOFTSIM_COMMAND", &command);
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

TEST_WITH(obeys_commands, make_folder, tear_down)
{
    watch w;
    start_daemon(tube(), NULL);
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
    start_daemon(tube(), closed);
    expect_reply(&w, "status", "", 0);
    expect_reply(&w, "shutdown", "", 1);
    watch_close(&w);
    assert_int_equal(stop_daemon(), 0);
}

/* ---- the topology ---- */

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
        const double phi = 2.0 * SS_PI * (file % GRID_COLUMNS) / GRID_COLUMNS;
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
TEST_WITH(the_topology_leads_back_to_the_files_numbers, make_folder, tear_down)
{
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

TEST_WITH(monitor_sends_commands, make_folder, tear_down)
{
    static const struct {
        const char *command, *said;
        int status;
    } cases[] = {{"pause", "paused: ", 0},
                 {"resume", "running again\n", 0},
                 {"set haptic.max_force_n=5", "haptic.max_force_n = 5 N (was 8)\n", 0},
                 {"set haptic.max_force_n=4", "haptic.max_force_n = 4 N (was 5)\n", 0},
                 {"set haptic.between_steps=hold", "haptic.between_steps = hold (was local)\n", 0},
                 {"set haptic.max_force_n=-5", "haptic.max_force_n is -5", 2},
                 {"dance", "unknown command 'dance'", 2}};
    start_daemon(tube(), NULL);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const char *const argv[] = {"softsim-monitor", "--command", cases[i].command, NULL};
        const int status = process_run(&client, argv);
        if (status != cases[i].status || !strstr(client.out, cases[i].said)) {
            fail_msg("%s: %d: %s%s", cases[i].command, status, client.out, client.err);
        }
    }
    /* A pose for a probe that the scene has no tool for: the status knows why nothing answers. */
    const char *const bridge[] = {"softsim-bridge", "--device", "sim",     "--offset-m", "0,0,0",
                                  "--probe",        "5",        "--ticks", "50",         NULL};
    assert_int_equal(process_run(&client, bridge), 1);
    assert_non_null(strstr(client.err, "(wrong probe); has its scene a tool for probe 5"));
    assert_int_equal(stop_daemon(), 0);

    const char *const closed[] = {"--no-commands", NULL};
    const char *const argv[] = {"softsim-monitor", "--command", "pause", NULL};
    start_daemon(tube(), closed);
    assert_int_equal(process_run(&client, argv), 1);
    assert_non_null(strstr(client.out, "refused"));
    assert_int_equal(stop_daemon(), 0);
}

/* ---- status and scene ---- */

static bool says_slow(const watch *w)
{
    return w->statuses > 0 && w->status.verdict == SOFTSIM_VERDICT_DEGRADED;
}

static bool says_slow_and_how_much(const watch *w)
{
    return says_slow(w) && w->status.uptime_s > 2.0 && w->status.simulation_rate_hz > 0.0;
}

static bool sleeps(const watch *w)
{
    return w->statuses > 0 && w->status.active_nodes == 0 && w->status.substeps == 0 &&
           w->status.step > 0;
}

static bool is_awake(const watch *w)
{
    return w->statuses > 0 && w->status.active_nodes > 0;
}

static int64_t step_asleep;

static bool sleeps_on(const watch *w)
{
    return sleeps(w) && w->status.step > step_asleep;
}

static bool feels(const watch *w)
{
    return w->statuses > 0 && w->status.energy_from_device_j > 0.0 && w->status.active_nodes > 0;
}

/* Nobody comes: the model is not stepped, its time goes on, a command wakes it, and so does a
 * tool, which feels it. */
TEST_WITH(a_server_at_rest_sleeps_and_wakes, make_folder, tear_down)
{
    watch w;
    watch_open(&w);
    start_kidney();
    watch_until(&w, sleeps, "sleep");
    step_asleep = w.status.step + 500;
    watch_until(&w, sleeps_on, "steps that go by asleep");
    assert_int_equal(w.status.verdict, SOFTSIM_VERDICT_GOOD);
    expect_reply(&w, "reset", "", 0);
    watch_until(&w, is_awake, "a model that was reset");
    watch_until(&w, sleeps, "sleep again");
    /* Held until it is felt: a server that is held up may not see a poke come and go. */
    const char *const bridge[] = {"softsim-bridge", "--device", "sim", "--script", "press", NULL};
    process_start(&client, bridge, NULL);
    watch_until(&w, feels, "a press");
    process_signal(&client, SIGTERM);
    (void)process_finish(&client);
    watch_until(&w, sleeps, "sleep after a press");
    watch_close(&w);
    assert_int_equal(stop_daemon(), 0);
}

/* So light and so stiff that a quarter of a millisecond takes some dozens of sub-steps. */
TEST_WITH(a_slow_server_says_so, make_folder, tear_down)
{
    const char *const slow[] = {
        "--set", "haptic.rate_hz=4000",           "--set", "simulation.rate_hz=4000",
        "--set", "model.area_density_kg_m2=1e-6", "--set", "model.damping_n_s_per_m3=1",
        "--set", "simulation.max_substeps=1000",  NULL};
    watch w;
    start_daemon(KIDNEY, slow);
    watch_open(&w);
    watch_until(&w, says_slow, "a status that is degraded");
    watch_until(&w, says_slow_and_how_much, "a status that tells a rate");
    int percent = 0;
    assert_int_equal(sscanf(w.reason, "simulated %d %% of real time: ", &percent), 1);
    assert_non_null(strstr(w.reason, "lower simulation.rate_hz, choose a coarser mesh"));
    print_message("%d %% of real time, %.0f of 4000 steps a second\n", percent,
                  w.status.simulation_rate_hz);
    assert_in_range(percent, 0, 94);
    assert_true(w.status.simulation_rate_hz < 0.95 * 4000.0);
    watch_close(&w);
    assert_int_equal(stop_daemon(), 0);
    const char *said = strstr(daemon_process.err, "warning: degraded: simulated ");
    assert_non_null(said);
}

TEST_WITH(monitor_prints_one_status, make_folder, tear_down)
{
    start_daemon(tube(), NULL);
    const char *const monitor[] = {"softsim-monitor", "--once", "--json", NULL};
    assert_int_equal(process_run(&client, monitor), 0);
    assert_non_null(strstr(client.out, "\"model\": \"cnn-energy\""));
    assert_non_null(strstr(client.out, "\"verdict\""));
    assert_int_equal(stop_daemon(), 0);
}

/* ---- packets ---- */

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

TEST_WITH(no_fragment_crashes_server_or_client, make_folder, tear_down)
{
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    assert_true(fd >= 0);
    start_daemon(tube(), NULL);
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
    return process_run_tests(NULL, NULL);
}
