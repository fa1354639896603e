/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * One server a prefix: real daemons that meet, and clients that hear two. A stopped process stands
 * for a server that is not heard while another starts.
 */
#include "common/test.h"

#include <stdlib.h>
#include <unistd.h>

#include "common/effort.h"
#include "daemon_fixture.h"
#include "rt/vec.h"

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
TEST_WITH(the_second_names_the_first_and_does_not_start, make_folder, tear_down)
{
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

TEST_WITH(a_killed_server_is_followed_at_once, make_folder, tear_down)
{
    start_daemon(tube(), NULL);
    process_signal(&daemon_process, SIGKILL);
    process_finish(&daemon_process);
    start_daemon(tube(), NULL);
    assert_int_equal(stop_daemon(), 0);
    assert_null(strstr(daemon_process.err, "another server"));
}

/* And has nothing to say of it: it runs on beyond its first statuses, which is when it would. */
TEST_WITH(takeover_ends_the_first, make_folder, tear_down)
{
    start_daemon(tube(), NULL);
    const char *const argv[] = {"softsimd", tube(), "--takeover", "--duration", "0.6", NULL};
    process_start(&other, argv, NULL);
    assert_int_equal(process_finish(&daemon_process), 0);
    assert_int_equal(process_finish(&other), 0);
    expect_text(other.out, "softsimd: ready");
    assert_null(strstr(other.err, "another server"));
}

static bool is_answering(const watch *w)
{
    return w->forces > 0;
}

/* Neither heard the other at its start: the younger goes. */
TEST_WITH(of_two_that_run_the_younger_gives_way, make_folder, tear_down)
{
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

/* A replay names no force in effect: who was served by the elder is told from who came to the
 * younger by its having sent before. Where a busy machine held it back meanwhile, or the elder for
 * ten seconds, the younger stays, and it is done again. */
TEST_WITH(beside_a_client_of_the_elder_the_younger_gives_way, make_folder, tear_down)
{
    static watch w;
    const char *const replay[] = {"softsim-replay", POKE, "--repeat", "1000", NULL};
    start_daemon(tube(), NULL);
    watch_open(&w);
    process_start(&client, replay, NULL);
    watch_until(&w, is_answering, "a force");
    watch_close(&w);
    bool has_stayed = true;
    for (int attempt = 0; attempt < 8 && has_stayed; ++attempt) {
        process_signal(&daemon_process, SIGSTOP);
        start_other(tube(), NULL);
        const bool is_ready = process_wait_for(&other, "softsimd: ready");
        process_signal(&daemon_process, SIGCONT);
        assert_true(is_ready);
        has_stayed = process_wait_for(&other, "warning: another server answers");
        if (has_stayed) {
            process_signal(&other, SIGTERM);
        }
        process_finish(&other);
    }
    assert_false(has_stayed);
    assert_int_equal(other.status, 1);
    expect_text(other.err, "gives way to the server that was first on prefix SOFTSIM: ");
    process_kill(&client);
    assert_int_equal(stop_daemon(), 0);
}

/* Statuses that come once a second, as of a server that is held up, or of ever another server: who
 * is not confirmed does not keep one from starting. */
TEST_WITH(statuses_of_nobody_hold_up_no_start, make_folder, tear_down)
{
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

/* The force of a line of the bridge's file; how far it is from the one before. */
static double take_force(char *line, double force[3])
{
    double value[14], step[3];
    for (int i = 0; i < 14; ++i) {
        value[i] = strtod(line, &line);
        line += *line == ',';
    }
    ss_sub3(step, value + 10, force);
    ss_copy3(force, value + 10);
    return magnitude(step);
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
        const double step_n = take_force(line + 1, last);
        ++rows;
        *out_jump = fmax(*out_jump, step_n);
        *out_late = rows > 1000 ? fmax(*out_late, magnitude(last)) : *out_late;
    }
    assert_int_equal(rows, 2000);
}

TEST_WITH(a_bridge_lets_go_where_two_servers_answer, make_folder, tear_down)
{
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
    read_forces("two.csv.part", &late, &jump);
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

/* Until the force has stayed where it is, within a hundredth, for 300 messages without a ramp. */
static softsim_force wait_for_rest(watch *w)
{
    const double begin_s = process_now_s();
    double at_n = 0.0;
    long seen = w->forces;
    for (int quiet = 0; quiet < 300;) {
        lcm_handle_timeout(w->lcm, 200);
        if (process_has_ended(&client) || process_now_s() - begin_s > HANG_S) {
            fail_msg("no force at rest, %g N: %s", at_n, client.err);
        }
        if (w->forces == seen) {
            continue;
        }
        seen = w->forces;
        const double force_n = magnitude(w->force.force);
        const bool is_quiet = force_n > 0.0 && (w->force.flags & SOFTSIM_FORCE_RAMPING) == 0 &&
                              fabs(force_n - at_n) <= 0.01 * at_n;
        quiet = is_quiet ? quiet + 1 : 0;
        at_n = is_quiet ? at_n : force_n;
    }
    return (softsim_force){.force = {w->force.force[0], w->force.force[1], w->force.force[2]},
                           .proxy = {w->force.proxy[0], w->force.proxy[1], w->force.proxy[2]}};
}

/* What a hand got from one server and from the next. */
typedef struct course {
    softsim_force first, second; /* at rest */
    double largest_n;            /* of the first, as the hand got it */
    double step_n;               /* the largest between two periods */
    int zeros;                   /* periods without a force between the two */
} course;

/* From the bridge's file. Behind the last force that is the first's, more than the second can give,
 * come zeros, then the second's. (A machine that held the bridge up may have let go of the first's
 * more than once.) */
static void read_course(const char *name, course *out)
{
    char line[2048];
    double last[3] = {0.0};
    const double apart_n = 0.5 * (magnitude(out->first.force) + magnitude(out->second.force));
    FILE *file = fopen(in_folder(name), "r");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file)); /* its header */
    while (fgets(line, sizeof line, file) != NULL) {
        const double step_n = take_force(line, last);
        const double force_n = magnitude(last);
        out->step_n = fmax(out->step_n, step_n);
        out->largest_n = fmax(out->largest_n, force_n);
        out->zeros = force_n > apart_n ? 0 : out->zeros + (force_n == 0.0);
    }
    fclose(file);
}

static void follow(const char *const *first, const char *const *second, const char *const *takeover,
                   const char *const *bridge, course *out)
{
    static watch w;
    memset(&w, 0, sizeof w);
    *out = (course){.zeros = 0};
    process_start(&daemon_process, first, NULL);
    assert_true(process_wait_for(&daemon_process, "softsimd: ready"));
    watch_open(&w);
    process_start(&client, bridge, NULL);
    out->first = wait_for_rest(&w);
    /* On a busy machine it hears the first a little late, and gives way; or stays where the client
     * went without a force meanwhile. */
    int status = 1;
    for (int attempt = 0; attempt < 5 && status < 2; ++attempt) {
        process_start(&other, second, NULL);
        if (process_wait_for(&other, "warning: another server answers")) {
            process_signal(&other, SIGTERM);
        }
        status = process_finish(&other);
    }
    assert_int_equal(status, 2);
    out->first = wait_for_rest(&w); /* the first goes on */
    process_start(&other, takeover, NULL);
    assert_int_equal(process_finish(&daemon_process), 0);
    assert_true(process_wait_for(&other, "softsimd: ready"));
    while (lcm_handle_timeout(w.lcm, 0) > 0) { /* what the first has said */
    }
    out->second = wait_for_rest(&w);
    process_signal(&client, SIGINT);
    assert_int_equal(process_finish(&client), 1); /* the path goes on */
    watch_close(&w);
    process_signal(&other, SIGTERM);
    assert_int_equal(process_finish(&other), 0);
    read_course("held.csv.part", out);
}

/* The first's force ends in twenty messages, a twentieth in each, of which two may come in one
 * period of the bridge, whose clock is another. It was at rest within a hundredth. */
static bool is_ramp(const course *c)
{
    return c->step_n <= 1.01 * 2.0 * c->largest_n / 20.0;
}

/* A tool held 4 mm below where it touched, on two blocks of which one is five times as stiff as the
 * other. Mixed, the hand would get now the one and now the other, four fifths of the first's apart.
 * Where a busy machine brought more than two messages in one period, it is done again. */
TEST_WITH(under_a_bridge_one_force_ends_before_the_other_begins, make_folder, tear_down)
{
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
    const char *const generate[] = {"softsim-mesh",
                                    "generate",
                                    "block",
                                    "--tetrahedra",
                                    "--size-mm",
                                    "80,80,40",
                                    "--out",
                                    mesh,
                                    "--points",
                                    FULL_IN_RELEASE("800", "200"),
                                    NULL};
    const char *const first[] = {"softsimd", stiff_scene, NULL};
    const char *const second[] = {"softsimd", soft_scene, NULL};
    const char *const takeover[] = {"softsimd", soft_scene, "--takeover", NULL};
    const char *const bridge[] = {"softsim-bridge", "--device", "script", "--path", path,
                                  "--csv",          csv,        NULL};
    assert_int_equal(process_run(&client, generate), 0);
    course c = {.step_n = INFINITY};
    for (int attempt = 0; attempt < 8 && !is_ramp(&c); ++attempt) {
        follow(first, second, takeover, bridge, &c);
        print_message("first %.4f N, then %d periods of zero, then %.4f N; largest step %.4f N\n",
                      magnitude(c.first.force), c.zeros, magnitude(c.second.force), c.step_n);
    }
    assert_true(is_ramp(&c));
    assert_true(c.zeros > 0);
    /* At one depth the force goes with the modulus. The coupling lets the tool sink in less on the
     * stiffer block; a force goes with the depth as that of a flat tool at least, d, and as d^2 at
     * most (a sphere: d^1.5). Each force is at rest within a hundredth. */
    const double touch_m = 0.020 + 0.008;
    const double deeper = (touch_m - c.second.proxy[2]) / (touch_m - c.first.proxy[2]);
    const double share = 5.0 * magnitude(c.second.force) / magnitude(c.first.force);
    print_message("%.4f of a fifth, %.4f as deep\n", share, deeper);
    assert_true(deeper > 0.98);
    assert_true(share > 0.98 * deeper && share < 1.02 * deeper * deeper);
}

TEST_WITH(watching_and_replaying_clients_say_that_there_are_two, make_folder, tear_down)
{
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

TEST_WITH(a_monitor_says_that_another_server_answers, make_folder, tear_down)
{
    const char *const watching[] = {"softsim-monitor", "--json", NULL};
    start_daemon(tube(), NULL);
    process_start(&client, watching, NULL);
    assert_true(process_wait_for(&client, "uptime_s"));
    start_other(tube(), "--takeover");
    assert_true(process_wait_for(&client, "another server answers, and is shown from now on"));
    process_signal(&client, SIGINT);
    assert_int_equal(process_finish(&client), 1);
    process_signal(&other, SIGTERM);
    assert_int_equal(process_finish(&other), 0);
    assert_int_equal(process_finish(&daemon_process), 0);
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
