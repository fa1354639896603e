/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * One server a prefix: real daemons that meet, and clients that hear two. A stopped process stands
 * for a server that is not heard while another starts.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>
#include <unistd.h>

#include "daemon_fixture.h"

static const char *const stiff = "model.modulus_j=10";
static const char *const soft = "model.modulus_j=1";

static void start_other(const char *option)
{
    const char *const argv[] = {"softsimd", KIDNEY, "--set", soft, option, NULL};
    process_start(&other, argv, NULL);
}

static void expect_text(const char *text, const char *wanted)
{
    if (!strstr(text, wanted)) {
        fail_msg("no '%s' in: %s", wanted, text);
    }
}

/* On a machine that has no time for the first one's answer the second gives way a little later. */
static void the_second_names_the_first_and_does_not_start(void **state)
{
    (void)state;
    int status = 1;
    start_daemon(NULL);
    for (int attempt = 0; attempt < 5 && status == 1; ++attempt) {
        start_other(NULL);
        status = process_finish(&other);
    }
    assert_int_equal(status, 2);
    assert_string_equal(other.out, "");
    expect_text(other.err, "another server answers on prefix SOFTSIM: " KIDNEY ", up ");
    expect_text(other.err, "--takeover");
    const char *const elsewhere[] = {"softsimd",   KIDNEY, "--prefix", "ELSEWHERE",
                                     "--duration", "0.1",  NULL};
    assert_int_equal(process_run(&other, elsewhere), 0);
    assert_null(strstr(other.err, "another server"));
    assert_int_equal(stop_daemon(), 0);
}

static void a_killed_server_is_followed_at_once(void **state)
{
    (void)state;
    start_daemon(NULL);
    process_signal(&daemon_process, SIGKILL);
    process_finish(&daemon_process);
    start_daemon(NULL);
    assert_int_equal(stop_daemon(), 0);
    assert_null(strstr(daemon_process.err, "another server"));
}

/* And has nothing to say of it: it runs on beyond its first statuses, which is when it would. */
static void takeover_ends_the_first(void **state)
{
    (void)state;
    start_daemon(NULL);
    const char *const argv[] = {"softsimd", KIDNEY, "--takeover", "--duration", "0.6", NULL};
    process_start(&other, argv, NULL);
    assert_int_equal(process_finish(&daemon_process), 0);
    assert_int_equal(process_finish(&other), 0);
    expect_text(other.out, "softsimd: ready");
    assert_null(strstr(other.err, "another server"));
}

/* Neither heard the other at its start: the younger goes. */
static void of_two_that_run_the_younger_gives_way(void **state)
{
    (void)state;
    start_daemon(NULL);
    process_signal(&daemon_process, SIGSTOP);
    start_other(NULL);
    assert_true(process_wait_for(&other, "softsimd: ready"));
    process_signal(&daemon_process, SIGCONT);
    assert_int_equal(process_finish(&other), 1);
    expect_text(other.err, "gives way to the server that was first on prefix SOFTSIM: " KIDNEY);
    assert_int_equal(stop_daemon(), 0);
}

/* Statuses that come once a second, as of a server that is held up, or of ever another server: who
 * is not confirmed does not keep one from starting. */
static void statuses_of_nobody_hold_up_no_start(void **state)
{
    (void)state;
    char none[] = "";
    softsim_server_status_t status = {.scene = none, .model = none, .reason = none};
    lcm_t *lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(lcm);
    const char *const brief[] = {"softsimd", KIDNEY, "--duration", "0.1", NULL};
    process_start(&other, brief, NULL);
    const double begin_s = process_now_s();
    while (!process_has_ended(&other) && process_now_s() - begin_s < 20.0) {
        status.utime += 10000000;
        softsim_server_status_t_publish(lcm, "SOFTSIM_STATUS", &status);
        usleep(100000);
    }
    lcm_destroy(lcm);
    assert_true(process_has_ended(&other));
    assert_int_equal(process_finish(&other), 0);
}

/* ---- clients that hear two ------------------------------------------------------------------ */

/* Two that stay: the first takes no commands, the second was started to take over. */
static void start_two(void)
{
    const char *const closed[] = {"--no-commands", "--set", stiff, NULL};
    start_daemon(closed);
    process_signal(&daemon_process, SIGSTOP);
    start_other("--takeover");
    assert_true(process_wait_for(&other, "softsimd: ready"));
    process_signal(&daemon_process, SIGCONT);
}

static void stop_two(void)
{
    process_signal(&other, SIGTERM);
    assert_int_equal(process_finish(&other), 0);
    assert_int_equal(stop_daemon(), 0);
}

/* From the bridge's file: the largest force of its second half, and the largest step of all. */
static void read_forces(const char *name, double *out_late, double *out_jump)
{
    static char text[4 << 20];
    double last[3] = {0.0, 0.0, 0.0};
    int rows = 0;
    *out_late = *out_jump = 0.0;
    read_text(name, text, sizeof text);
    for (char *line = strchr(text, '\n'); line && line[1] != '\0'; line = strchr(line + 1, '\n')) {
        double value[14], step[3];
        char *at = line + 1;
        for (int i = 0; i < 14; ++i) {
            value[i] = strtod(at, &at);
            at += *at == ',';
        }
        for (int i = 0; i < 3; ++i) {
            step[i] = value[10 + i] - last[i];
            last[i] = value[10 + i];
        }
        ++rows;
        *out_jump = fmax(*out_jump, magnitude(step));
        *out_late = rows > 1000 ? fmax(*out_late, magnitude(last)) : *out_late;
    }
    assert_int_equal(rows, 2000);
}

static void a_bridge_lets_go_where_two_servers_answer(void **state)
{
    (void)state;
    double late = 0.0, jump = 0.0;
    start_two();
    const char *const argv[] = {"softsim-bridge",
                                "--device",
                                "sim",
                                "--script",
                                "press",
                                "--offset-m",
                                "0,0.006,0.0273",
                                "--ticks",
                                "2000",
                                "--csv",
                                in_folder("two.csv"),
                                NULL};
    assert_int_equal(process_run(&client, argv), 1);
    read_forces("two.csv", &late, &jump);
    print_message("force %.3g N, largest step %.3g N\n", late, jump);
    expect_text(client.err, "two servers answer on this prefix: the force is let go");
    assert_true(late == 0.0);
    stop_two();
}

static void watching_and_replaying_clients_say_that_there_are_two(void **state)
{
    (void)state;
    start_two();
    const char *const watching[] = {"softsim-monitor", "--duration", "20", NULL};
    process_start(&client, watching, NULL);
    assert_true(process_wait_for(&client, "two servers answer on this prefix: the first is shown"));
    process_signal(&client, SIGINT);
    assert_int_equal(process_finish(&client), 1);
    const char *const playing[] = {"softsim-replay", POKE, "--speed", "4", NULL};
    assert_int_equal(process_run(&client, playing), 1);
    expect_text(client.err, "two servers answer on this prefix: the first one's answers are kept");
    stop_two();
    /* One alone is taken for one. */
    start_daemon(NULL);
    assert_int_equal(process_run(&client, playing), 0);
    assert_int_equal(stop_daemon(), 0);
}

int main(void)
{
    if (!process_isolate()) {
        fprintf(stderr, "skipped: no private network namespace allowed here\n");
        return 77;
    }
#define TEST(name) cmocka_unit_test_setup_teardown(name, make_folder, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(the_second_names_the_first_and_does_not_start),
        TEST(a_killed_server_is_followed_at_once),
        TEST(takeover_ends_the_first),
        TEST(of_two_that_run_the_younger_gives_way),
        TEST(statuses_of_nobody_hold_up_no_start),
        TEST(a_bridge_lets_go_where_two_servers_answer),
        TEST(watching_and_replaying_clients_say_that_there_are_two),
    };
    return cmocka_run_group_tests_name("two servers", tests, NULL, NULL);
}
