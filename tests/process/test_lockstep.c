/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What lockstep promises beyond the hash of a whole log: it ends on its tick, and counts the
 * forces that count.
 */
#include "common/test.h"

#include <lcm/lcm.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/kidney.h"
#include "common/pose_fixture.h"
#include "process.h"
#include "softsim/log.h"
#include "softsim/types.h"
#include "softsim_command_t.h"
#include "softsim_contact_force_t.h"
#include "softsim_probe_pose_t.h"
#include "softsim_reply_t.h"
#include "softsim_server_status_t.h"

#define SCENES SOURCE_DIR "/server/scenes/"
#define POKE   SCENES "kidney-poke.lcmlog"

static process server, client;

static int tear_down(void **state)
{
    process_kill(&client);
    process_kill(&server);
    return 0;
}

static void start(const char *const *argv)
{
    process_start(&server, argv, NULL);
    if (!process_wait_for(&server, "softsimd: ready")) {
        fail_msg("no ready line; stderr: %s", server.err);
    }
}

static void last_word(const char *text, char out[32])
{
    out[0] = '\0';
    for (const char *at = text; sscanf(at, "%31s", out) == 1;) {
        at = strstr(at, out) + strlen(out);
    }
}

/* Starts the daemon `argv` and plays the probe's `log` to it until it ends by itself. */
static void serve_log(const char *const *argv, const char *log)
{
    start(argv);
    const char *const replay[] = {"softsim-replay", log, "--lockstep", NULL};
    process_start(&client, replay, NULL);
    assert_int_equal(process_finish(&server), 0);
    process_signal(&client, SIGKILL);
    process_finish(&client);
}

/* A client that goes on sending must not move the world past its end: else the hash would tell
 * how fast the machine is. */
TEST_WITH(duration_ends_on_its_tick, NULL, tear_down)
{
    const char *const durations[] = {"0.3", FULL_IN_RELEASE("0.501", "0.101")};
    for (int i = FULL_IN_RELEASE(0, 1); i < 2; ++i) {
        const char *const run[] = {"softsim-run", KIDNEY, "--set",      kidney_mesh(),
                                   "--poses",     POKE,   "--duration", durations[i],
                                   "--hash",      NULL};
        assert_int_equal(process_run(&client, run), 0);
        char wanted[32], got[32];
        last_word(client.out, wanted);
        const char *const argv[] = {"softsimd",    KIDNEY,       "--set",
                                    kidney_mesh(), "--lockstep", "--duration",
                                    durations[i],  "--hash",     NULL};
        serve_log(argv, POKE);
        last_word(server.out, got);
        assert_int_equal(strlen(got), 16);
        assert_string_equal(got, wanted);
    }
}

/* The log POKE as of a session in which another sender was refused, ten times a second told so. */
static void write_session(const char *path)
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_poses *poke = NULL;
    softsim_log_writer *writer = NULL;
    softsim_pose_event event;
    char note[256];
    int count = 0;
    assert_int_equal(softsim_poses_open(POKE, 1000.0, &poke, &error), SOFTSIM_OK);
    assert_int_equal(softsim_log_create(path, &writer, &error), SOFTSIM_OK);
    while (softsim_poses_next(poke, &event, note, sizeof note) == SOFTSIM_POSES_POSE) {
        const softsim_force taken = {.sender = event.pose.sender, .pose_seq = event.pose.seq};
        const softsim_force refused = {
            .sender = 77, .pose_seq = ++count, .flags = SOFTSIM_FORCE_OTHER_SENDER};
        softsim_pose other = event.pose;
        softsim_poses_restamp(&other, 77, count);
        other.position[0] += 0.01;
        softsim_log_write_pose(writer, event.time_us, "SOFTSIM_PROBE_0", &event.pose);
        softsim_log_write_force(writer, event.time_us, "SOFTSIM_FORCE_0", &taken);
        softsim_log_write_pose(writer, event.time_us, "SOFTSIM_PROBE_0", &other);
        if (count % 100 == 1) {
            softsim_log_write_force(writer, event.time_us, "SOFTSIM_FORCE_0", &refused);
        }
    }
    softsim_poses_close(&poke);
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
}

/* Both play what the server took then, as if the other had not been there. */
TEST_WITH(poses_that_were_refused_are_left_out_of_a_log, NULL, tear_down)
{
    const char *const duration = FULL_IN_RELEASE("1.2", "0.101"); /* pressed at 0.85 */
    char session[] = "/tmp/softsim_session_XXXXXX";
    const int file = mkstemp(session);
    assert_true(file >= 0);
    close(file);
    write_session(session);
    char wanted[32], got[2][32];
    for (int i = 0; i < 2; ++i) {
        const char *const run[] = {"softsim-run", KIDNEY,       "--set",  kidney_mesh(), "--poses",
                                   session,       "--duration", duration, "--hash",      NULL};
        const char *plain[10];
        memcpy(plain, run, sizeof run);
        plain[5] = POKE;
        assert_int_equal(process_run(&client, i == 0 ? plain : run), 0);
        last_word(client.out, i == 0 ? wanted : got[0]);
    }
    const char *const argv[] = {"softsimd",   KIDNEY,   "--set",  kidney_mesh(), "--lockstep",
                                "--duration", duration, "--hash", NULL};
    serve_log(argv, session);
    unlink(session);
    last_word(server.out, got[1]);
    assert_string_equal(got[0], wanted);
    assert_string_equal(got[1], wanted);
}

/* The greatest force of a CSV of softsim-run, N. */
static double largest_force(const char *path)
{
    FILE *file = fopen(path, "r");
    char line[512];
    double largest = 0.0;
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    while (fgets(line, sizeof line, file)) {
        double x, y, z;
        assert_int_equal(sscanf(line, "%*d,%*f,%*d,%lf,%lf,%lf", &x, &y, &z), 3);
        largest = fmax(largest, sqrt(x * x + y * y + z * z));
    }
    fclose(file);
    return largest;
}

/* The model without forces is felt through the coupling, with a result each tick too, and in the
 * same way in both programs. */
TEST_WITH(chainmail_is_felt_in_lockstep, NULL, tear_down)
{
    const char *const duration = FULL_IN_RELEASE("1.5", "0.9"); /* pressed at 0.85 */
    char scene[] = "/tmp/softsim_mail_XXXXXX.yaml", csv[] = "/tmp/softsim_mail_XXXXXX.csv";
    const int file = mkstemps(scene, 5), table = mkstemps(csv, 4);
    assert_true(file >= 0 && table >= 0);
    dprintf(file,
            "softsim: 1\n"
            "object:\n  mesh: %s\n  units: mm\n"
            "  fixed: [{sphere: {center_m: [0, -0.017, 0], radius_m: 0.015}}]\n"
            "model: {name: chainmail}\n"
            "contact:\n  tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}]\n"
            "simulation: {rate_hz: 1000}\n",
            FULL_IN_LONG_RUN(KIDNEY_MESH, SMALL_MESH));
    close(file);
    close(table);
    const char *const run[] = {"softsim-run", scene,   "--poses", POKE,     "--duration",
                               duration,      "--csv", csv,       "--hash", NULL};
    assert_int_equal(process_run(&client, run), 0);
    char wanted[32], got[32];
    last_word(client.out, wanted);
    const double largest = largest_force(csv);
    print_message("chainmail: %.3f N at most\n", largest);
    const char *const argv[] = {"softsimd", scene,    "--lockstep", "--duration",
                                duration,   "--hash", NULL};
    serve_log(argv, POKE);
    unlink(scene);
    unlink(csv);
    last_word(server.out, got);
    assert_string_equal(got, wanted);
    assert_true(largest > 0.5);
}

/* Neither has a clock to meet: simulation.max_substeps limits neither, and they agree. */
TEST_WITH(a_budget_that_would_bind_changes_nothing, NULL, tear_down)
{
    SKIP_WHERE_REPEATED();
    static const char *const budgets[] = {"simulation.max_substeps=2",
                                          "simulation.max_substeps=500"};
    const char *const duration = FULL_IN_LONG_RUN("0.2", "0.05");
    char wanted[32], got[32];
    for (int i = 0; i < 2; ++i) {
        const char *const run[] = {"softsim-run",
                                   KIDNEY,
                                   "--set",
                                   kidney_mesh(),
                                   "--poses",
                                   POKE,
                                   "--duration",
                                   duration,
                                   "--hash",
                                   "--set",
                                   "model.area_density_kg_m2=1e-3",
                                   "--set",
                                   budgets[i],
                                   NULL};
        assert_int_equal(process_run(&client, run), 0);
        last_word(client.out, i == 0 ? wanted : got);
        assert_null(strstr(client.err, "max_substeps"));
    }
    assert_string_equal(got, wanted);
    const char *const argv[] = {
        "softsimd",   KIDNEY,     "--set",  kidney_mesh(), "--lockstep",
        "--duration", duration,   "--hash", "--set",       "model.area_density_kg_m2=1e-3",
        "--set",      budgets[0], NULL};
    serve_log(argv, POKE);
    last_word(server.out, got);
    assert_string_equal(got, wanted);
}

/* Still for long enough that the body sleeps, then pressed, and still again. */
TEST_WITH(what_has_slept_hashes_the_same_in_lockstep, NULL, tear_down)
{
    char table[] = "/tmp/softsim_rest_XXXXXX.csv", log[64];
    const int file = mkstemps(table, 4);
    assert_true(file >= 0);
    dprintf(file, "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n"
                  "0,0,0,0.006,0.08,1,0,0,0,0\n1.6,0,0,0.006,0.08,1,0,0,0,0\n"
                  "1.9,0,0,0.006,0.025,1,0,0,0,0\n3,0,0,0.006,0.025,1,0,0,0,0\n");
    close(file);
    snprintf(log, sizeof log, "%s.lcmlog", table);
    const char *const convert[] = {"softsim-replay", "--convert", table, log, NULL};
    assert_int_equal(process_run(&client, convert), 0);
    unlink(table);
    char wanted[32], got[32];
    const char *const run[] = {"softsim-run", KIDNEY,       "--set", kidney_mesh(), "--poses",
                               log,           "--duration", "2.2",   "--hash",      NULL};
    assert_int_equal(process_run(&client, run), 0);
    last_word(client.out, wanted);
    const char *const argv[] = {"softsimd",   KIDNEY, "--set",  kidney_mesh(), "--lockstep",
                                "--duration", "2.2",  "--hash", NULL};
    serve_log(argv, log);
    unlink(log);
    last_word(server.out, got);
    assert_int_equal(strlen(got), 16);
    assert_string_equal(got, wanted);
}

/* ---- a client of our own ---- */

static softsim_contact_force_t force;
static int forces, statuses;
static int64_t periods, counted, missed, refused_other_sender;

static void on_force(const lcm_recv_buf_t *buffer, const char *channel,
                     const softsim_contact_force_t *message, void *user)
{
    (void)buffer, (void)channel, (void)user;
    force = *message;
    ++forces;
}

static void on_status(const lcm_recv_buf_t *buffer, const char *channel,
                      const softsim_server_status_t *message, void *user)
{
    (void)buffer, (void)channel, (void)user;
    periods = message->probe_periods[0];
    counted = message->probe_forces[0];
    missed = message->probe_missed[0];
    refused_other_sender = message->poses_refused[SOFTSIM_REFUSED_OTHER_SENDER];
    ++statuses;
}

static void wait_for(lcm_t *lcm, const int *count, int least, const char *what)
{
    const double begin_s = process_now_s();
    while (*count < least) {
        lcm_handle_timeout(lcm, 200);
        if (process_has_ended(&server) || process_now_s() - begin_s > HANG_S) {
            fail_msg("waited %.0f s for %s; server: %s", process_now_s() - begin_s, what,
                     server.err);
        }
    }
}

static void send_pose(lcm_t *lcm, int64_t sender, int32_t seq, double x)
{
    const softsim_probe_pose_t pose = {
        .sender = sender, .seq = seq, .position = {x, 0.0, 0.0}, PLAIN_POSE};
    const int before = forces;
    softsim_probe_pose_t_publish(lcm, "SOFTSIM_PROBE_0", &pose);
    wait_for(lcm, &forces, before + 1, "an answer");
    assert_int_equal(force.pose_seq, seq);
    assert_int_equal(force.sender, sender);
}

TEST_WITH(answers_to_another_sender_count_nowhere, NULL, tear_down)
{
    const char *const argv[] = {"softsimd", KIDNEY, "--set", kidney_mesh(), "--lockstep", NULL};
    start(argv);
    lcm_t *lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(lcm);
    softsim_contact_force_t_subscription_t *const heard_force =
        softsim_contact_force_t_subscribe(lcm, "SOFTSIM_FORCE_0", on_force, NULL);
    softsim_server_status_t_subscription_t *const heard_status =
        softsim_server_status_t_subscribe(lcm, "SOFTSIM_STATUS", on_status, NULL);
    send_pose(lcm, 1, 1, 0.2);
    assert_false(force.flags & SOFTSIM_FORCE_OTHER_SENDER);
    send_pose(lcm, 2, 1, 0.2); /* refused, answered, a tick: but no force */
    assert_true(force.flags & SOFTSIM_FORCE_OTHER_SENDER);
    send_pose(lcm, 1, 2, 0.9); /* a jump: refused, answered by the probe's force */
    assert_false(force.flags & SOFTSIM_FORCE_OTHER_SENDER);
    send_pose(lcm, 1, 3, 0.2);
    /* The holder's number from another address: refused, and neither the answer to it nor the one
     * kept for repeats is taken for the holder's. */
    lcm_t *forger = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(forger);
    const softsim_probe_pose_t forged = {
        .sender = 1, .seq = 4, .position = {0.2, 0.0, 0.0}, .orientation = {1.0, 0.0, 0.0, 0.0}};
    softsim_probe_pose_t_publish(forger, "SOFTSIM_PROBE_0", &forged);
    send_pose(lcm, 1, 4, 0.2);
    assert_false(force.flags & SOFTSIM_FORCE_OTHER_SENDER);
    lcm_destroy(forger);
    const softsim_command_t command = {.sender = 1, .id = 1, .name = "status", .argument = ""};
    const int before = statuses;
    softsim_command_t_publish(lcm, "SOFTSIM_COMMAND", &command);
    wait_for(lcm, &statuses, before + 2, "statuses");
    assert_int_equal(refused_other_sender, 2);
    assert_int_equal(periods, 4);
    assert_int_equal(counted, 4);
    assert_int_equal(missed, 0);
    softsim_contact_force_t_unsubscribe(lcm, heard_force);
    softsim_server_status_t_unsubscribe(lcm, heard_status);
    lcm_destroy(lcm);
    process_signal(&server, SIGTERM);
    assert_int_equal(process_finish(&server), 0);
}

/* The probe that a pose names itself is any number: it is refused, and answered on its channel. */
TEST_WITH(a_pose_may_name_any_probe, NULL, tear_down)
{
    static const int32_t named[] = {-1, 8, 1000, 100000000, INT32_MIN, INT32_MAX};
    const char *const argv[] = {"softsimd", KIDNEY, "--set", kidney_mesh(), "--lockstep", NULL};
    start(argv);
    lcm_t *lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(lcm);
    softsim_contact_force_t_subscription_t *const heard =
        softsim_contact_force_t_subscribe(lcm, "SOFTSIM_FORCE_[0-7]", on_force, NULL);
    int32_t seq = 0;
    for (int channel = 0; channel < SOFTSIM_MAX_PROBES; ++channel) {
        char name[32];
        snprintf(name, sizeof name, "SOFTSIM_PROBE_%d", channel);
        for (size_t i = 0; i < sizeof named / sizeof *named; ++i) {
            const softsim_probe_pose_t pose = {
                .sender = 77, .seq = ++seq, .probe = named[i], PLAIN_POSE};
            const int before = forces;
            softsim_probe_pose_t_publish(lcm, name, &pose);
            wait_for(lcm, &forces, before + 1, "an answer");
            assert_int_equal(force.pose_seq, seq);
            assert_int_equal(force.probe, channel);
        }
    }
    send_pose(lcm, 1, 1, 0.2); /* none of them holds the probe */
    assert_false(force.flags & SOFTSIM_FORCE_OTHER_SENDER);
    softsim_contact_force_t_unsubscribe(lcm, heard);
    lcm_destroy(lcm);
    process_signal(&server, SIGTERM);
    assert_int_equal(process_finish(&server), 0);
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
