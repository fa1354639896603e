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

static void start_other(const char *scene, const char *option)
{
    const char *const argv[] = {"softsimd", scene, "--set", soft, option, NULL};
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
    start_daemon(tube(), NULL);
    for (int attempt = 0; attempt < 5 && status == 1; ++attempt) {
        start_other(tube(), NULL);
        status = process_finish(&other);
    }
    assert_int_equal(status, 2);
    assert_string_equal(other.out, "");
    expect_text(other.err, "another server answers on prefix SOFTSIM: ");
    expect_text(other.err, tube());
    expect_text(other.err, "--takeover");
    const char *const elsewhere[] = {"softsimd",   tube(), "--prefix", "ELSEWHERE",
                                     "--duration", "0.1",  NULL};
    assert_int_equal(process_run(&other, elsewhere), 0);
    assert_null(strstr(other.err, "another server"));
    assert_int_equal(stop_daemon(), 0);
}

static void a_killed_server_is_followed_at_once(void **state)
{
    (void)state;
    start_daemon(tube(), NULL);
    process_signal(&daemon_process, SIGKILL);
    process_finish(&daemon_process);
    start_daemon(tube(), NULL);
    assert_int_equal(stop_daemon(), 0);
    assert_null(strstr(daemon_process.err, "another server"));
}

/* And has nothing to say of it: it runs on beyond its first statuses, which is when it would. */
static void takeover_ends_the_first(void **state)
{
    (void)state;
    start_daemon(tube(), NULL);
    const char *const argv[] = {"softsimd", tube(), "--takeover", "--duration", "0.6", NULL};
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
    start_daemon(tube(), NULL);
    process_signal(&daemon_process, SIGSTOP);
    start_other(tube(), NULL);
    assert_true(process_wait_for(&other, "softsimd: ready"));
    process_signal(&daemon_process, SIGCONT);
    assert_int_equal(process_finish(&other), 1);
    expect_text(other.err, "gives way to the server that was first on prefix SOFTSIM: ");
    expect_text(other.err, tube());
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
    const char *const brief[] = {"softsimd", tube(), "--duration", "0.1", NULL};
    process_start(&other, brief, NULL);
    const double begin_s = process_now_s();
    while (!process_has_ended(&other) && process_now_s() - begin_s < HANG_S) {
        status.utime += 10000000;
        softsim_server_status_t_publish(lcm, "SOFTSIM_STATUS", &status);
        usleep(100000);
    }
    lcm_destroy(lcm);
    assert_true(process_has_ended(&other));
    assert_int_equal(process_finish(&other), 0);
}

/* ---- clients that hear two ---- */

/* Two that stay: the first takes no commands, the second was started to take over. */
static void start_two(const char *scene)
{
    const char *const closed[] = {"--no-commands", "--set", stiff, NULL};
    start_daemon(scene, closed);
    process_signal(&daemon_process, SIGSTOP);
    start_other(scene, "--takeover");
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
    start_two(KIDNEY);
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

/* ---- one follows another under a bridge ---- */

static void write_block(const char *name, const char *modulus_pa)
{
    char text[512];
    snprintf(text, sizeof text,
             "softsim: 1\n"
             "object: {mesh: block.msh, units: mm, fixed: [{group: bottom}]}\n"
             "model: {name: fem, youngs_modulus_pa: %s, poisson_ratio: 0.45, density_kg_m3: 1060,\n"
             "        mass_damping_per_s: 30}\n"
             "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 8}}}]}\n"
             "haptic: {max_force_n: 5}\n",
             modulus_pa);
    write_text(name, text);
}

/* Until the newest force is of such a size. */
static void wait_for_force(watch *w, double least_n, double most_n)
{
    const double begin_s = process_now_s();
    do {
        lcm_handle_timeout(w->lcm, 200);
        if (process_has_ended(&client) || process_now_s() - begin_s > HANG_S) {
            fail_msg("no force from %g to %g N: %s", least_n, most_n, client.err);
        }
    } while (w->forces == 0 || magnitude(w->force.force) < least_n ||
             magnitude(w->force.force) > most_n);
}

/* A tool held 5 mm below where it touched, on two blocks of which one gives a fifth of the other's
 * force. Mixed, the hand would get now the one and now the other. */
static void under_a_bridge_one_force_ends_before_the_other_begins(void **state)
{
    (void)state;
    char line[2048];
    static watch w;
    if (!HAS_FEM) {
        skip();
    }
    write_block("stiff.yaml", "10000");
    write_block("soft.yaml", "2000");
    write_text("hold.csv", "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,0,0,0,0.029,1,0,0,0,0\n"
                           "1,0,0,0,0.024,1,0,0,0,0\n1000,0,0,0,0.024,1,0,0,0,0\n");
    char mesh[160], stiff_scene[160], soft_scene[160], path[160], csv[160];
    snprintf(mesh, sizeof mesh, "%s", in_folder("block.msh"));
    snprintf(stiff_scene, sizeof stiff_scene, "%s", in_folder("stiff.yaml"));
    snprintf(soft_scene, sizeof soft_scene, "%s", in_folder("soft.yaml"));
    snprintf(path, sizeof path, "%s", in_folder("hold.csv"));
    snprintf(csv, sizeof csv, "%s", in_folder("held.csv"));
    const char *const generate[] = {"softsim-mesh", "generate", "block", "--tetrahedra",
                                    "--size-mm",    "80,80,40", "--out", mesh,
                                    "--points",     "800",      NULL};
    const char *const first[] = {"softsimd", stiff_scene, NULL};
    const char *const second[] = {"softsimd", soft_scene, NULL};
    const char *const takeover[] = {"softsimd", soft_scene, "--takeover", NULL};
    const char *const bridge[] = {"softsim-bridge", "--device", "script", "--path", path,
                                  "--csv",          csv,        NULL};
    assert_int_equal(process_run(&client, generate), 0);
    process_start(&daemon_process, first, NULL);
    assert_true(process_wait_for(&daemon_process, "softsimd: ready"));
    watch_open(&w);
    process_start(&client, bridge, NULL);
    wait_for_force(&w, 0.5, 5.0);
    int status = 1; /* on a busy machine it hears the first a little late: gives way */
    for (int attempt = 0; attempt < 5 && status == 1; ++attempt) {
        process_start(&other, second, NULL);
        status = process_finish(&other);
    }
    assert_int_equal(status, 2);
    wait_for_force(&w, 0.5, 5.0); /* the first goes on */
    process_start(&other, takeover, NULL);
    assert_int_equal(process_finish(&daemon_process), 0);
    assert_true(process_wait_for(&other, "softsimd: ready"));
    while (lcm_handle_timeout(w.lcm, 0) > 0) { /* what the first has said */
    }
    wait_for_force(&w, 0.1, 0.2);
    process_signal(&client, SIGINT);
    assert_int_equal(process_finish(&client), 1); /* the path goes on */
    watch_close(&w);
    process_signal(&other, SIGTERM);
    assert_int_equal(process_finish(&other), 0);

    /* Behind the last force that is the first's come zeros, then the second's. (A machine that held
     * the bridge up may have let go of the first's more than once.) */
    const double apart = 0.3;
    double last[3] = {0.0}, largest = 0.0, before = 0.0, after = 0.0;
    int zeros = 0;
    FILE *file = fopen(in_folder("held.csv.part"), "r");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file)); /* its header */
    while (fgets(line, sizeof line, file) != NULL) {
        double value[14], step[3];
        char *at = line;
        for (int i = 0; i < 14; ++i) {
            value[i] = strtod(at, &at);
            at += *at == ',';
        }
        for (int i = 0; i < 3; ++i) {
            step[i] = value[10 + i] - last[i];
            last[i] = value[10 + i];
        }
        const double force = magnitude(last);
        largest = fmax(largest, magnitude(step));
        before = fmax(before, force);
        zeros = force > apart ? 0 : zeros + (force == 0.0);
        after = force > apart || zeros == 0 ? 0.0 : fmax(after, force);
    }
    fclose(file);
    print_message("first %.3f N, then %d ticks of zero, then %.3f N; largest change between two "
                  "ticks %.4f N\n",
                  before, zeros, after, largest);
    assert_true(before > 0.5 && zeros > 0);
    assert_true(after > 0.05);
}

static void watching_and_replaying_clients_say_that_there_are_two(void **state)
{
    (void)state;
    start_two(tube());
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
    start_daemon(tube(), NULL);
    assert_int_equal(process_run(&client, playing), 0);
    assert_int_equal(stop_daemon(), 0);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, make_folder, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(the_second_names_the_first_and_does_not_start),
        TEST(a_killed_server_is_followed_at_once),
        TEST(takeover_ends_the_first),
        TEST(of_two_that_run_the_younger_gives_way),
        TEST(statuses_of_nobody_hold_up_no_start),
        TEST(a_bridge_lets_go_where_two_servers_answer),
        TEST(under_a_bridge_one_force_ends_before_the_other_begins),
        TEST(watching_and_replaying_clients_say_that_there_are_two),
    };
    return PROCESS_RUN_GROUP("two servers", tests, NULL, NULL);
}
