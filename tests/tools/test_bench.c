/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * tools/bench: percentiles are exact, counters that do not add up are found, only first answers
 * within the run count, what is read is bounded and every fault has its line, what is written is
 * escaped, temporary folders go with what is in them and nothing else, children are reaped with the
 * right status.
 */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bench/core/child.h"
#include "bench/core/element_speed.h"
#include "bench/core/report.h"
#include "bench/latency/figures.h"
#include "bench/latency/judge.h"
#include "bench/latency/session.h"
#include "case/samples.h"
#include "case/scratch.h"
#include "common/folder_fixture.h"
#include "process.h"

#define assert_equal_double(a, b) assert_true(fabs((a) - (b)) <= 1e-12 * (1.0 + fabs(b)))

/* ---- samples ---- */

/* With a PATH in which there is nothing. First: it is said once a run. */
TEST(a_report_without_gnuplot_says_so_before_and_after)
{
    char text[4096], kept_path[4096];
    ss_page page;
    ss_output script;
    softsim_error error = {.status = SOFTSIM_OK};
    const char *nested = in_folder("drawn");
    assert_true(snprintf(kept_path, sizeof kept_path, "%s", getenv("PATH")) < 4096);
    setenv("PATH", "/nowhere", 1);
    int kept = divert(stderr, in_folder("before.txt"));
    assert_int_equal(ss_report_make_folder(nested, &error), SOFTSIM_OK);
    assert_int_equal(ss_report_make_folder(nested, &error), SOFTSIM_OK);
    restore(stderr, kept);
    assert_int_equal(ss_page_open(&page, nested, "page", "t", &error), SOFTSIM_OK);
    assert_int_equal(ss_plot_open(&script, nested, "curve", &error), SOFTSIM_OK);
    fputs("plot x\n", script.file);
    assert_int_equal(ss_page_plot(&page, &script, "curve", "caption", &error), SOFTSIM_OK);
    kept = divert(stderr, in_folder("after.txt"));
    assert_int_equal(ss_page_close(&page, &error), SOFTSIM_OK);
    restore(stderr, kept);
    setenv("PATH", kept_path, 1);
    read_text("before.txt", text, sizeof text);
    char *first = strstr(text, "gnuplot is not installed");
    assert_non_null(first);
    assert_non_null(strstr(first, "install gnuplot"));
    assert_null(strstr(first + 1, "gnuplot is not installed")); /* once */
    read_text("after.txt", text, sizeof text);
    assert_non_null(strstr(text, "warning: 1 picture is missing"));
    unlink(in_folder("drawn/page.html"));
    unlink(in_folder("drawn/curve.gp"));
    rmdir(nested);
}

TEST(quantiles_are_exact_samples)
{
    ss_samples samples;
    assert_true(ss_samples_init(&samples, 1000));
    assert_true(isnan(ss_samples_quantile(&samples, 0.5)));
    for (int i = 0; i < 1000; ++i) {
        ss_samples_add(&samples, (double)((i * 389) % 1000 + 1)); /* 1..1000, mixed up */
    }
    assert_equal_double(ss_samples_quantile(&samples, 0.0), 1.0);
    assert_equal_double(ss_samples_quantile(&samples, 0.5), 500.0);
    assert_equal_double(ss_samples_quantile(&samples, 0.99), 990.0);
    assert_equal_double(ss_samples_quantile(&samples, 0.999), 999.0);
    assert_equal_double(ss_samples_quantile(&samples, 1.0), 1000.0);
    ss_samples_fini(&samples);
}

TEST(samples_beyond_the_capacity_are_counted)
{
    ss_samples samples;
    assert_true(ss_samples_init(&samples, 2));
    for (int i = 0; i < 5; ++i) {
        ss_samples_add(&samples, i);
    }
    assert_int_equal(samples.count, 2);
    assert_int_equal(samples.dropped, 3);
    assert_equal_double(ss_samples_quantile(&samples, 1.0), 1.0);
    ss_samples_fini(&samples);
}

/* ---- figures ---- */

TEST(missed_periods_are_held_against_the_bare_loop)
{
    assert_true(ss_figures_is_missed_good(10000, 10, 10000, 0));
    assert_false(ss_figures_is_missed_good(10000, 11, 10000, 0));
    assert_true(ss_figures_is_missed_good(10000, 110, 10000, 50));
    assert_false(ss_figures_is_missed_good(10000, 111, 10000, 50));
    assert_true(ss_figures_is_missed_good(20000, 220, 10000, 50)); /* scaled to as many periods */
    assert_false(ss_figures_is_missed_good(1000, 2, 0, 0));
}

enum { SECOND_NS = 1000000000, STATUSES = 100 };

/* Four statuses a second from 0 on, a run from 2 s to 24 s; probe 0 misses one period in each
 * quarter of a second. The lateness of a status is its number. */
static void make_session(ss_session *session, ss_session_status status[STATUSES], ss_samples *echo,
                         ss_bare_tick *tick, int64_t tick_count)
{
    memset(session, 0, sizeof *session);
    memset(status, 0, STATUSES * sizeof *status);
    for (int i = 0; i < STATUSES; ++i) {
        status[i].receive_ns = (int64_t)i * SECOND_NS / 4;
        status[i].of.seq = i;
        status[i].of.probe_periods[0] = (int64_t)250 * i;
        status[i].of.probe_missed[0] = i;
        status[i].of.probe_forces[0] = (int64_t)249 * i;
        status[i].of.step = (int64_t)125 * i;
        for (int k = 0; k < 4; ++k) {
            status[i].of.lateness_us[k] = i + 0.1 * k;
        }
    }
    for (int64_t i = 0; i < tick_count; ++i) {
        tick[i] = (ss_bare_tick){i * SS_BARE_PERIOD_NS, (double)(i / 1000)};
    }
    *session = (ss_session){.begin_ns = 2LL * SECOND_NS,
                            .end_ns = 24LL * SECOND_NS,
                            .status = status,
                            .status_count = STATUSES,
                            .status_capacity = STATUSES};
    session->bare = (ss_bare_result){.tick = tick,
                                     .tick_count = tick_count,
                                     .periods = tick_count,
                                     .missed = 3,
                                     .echo_us = echo};
}

TEST(figures_come_from_the_run_alone)
{
    enum { TICKS = 26000 };
    static ss_bare_tick tick[TICKS];
    static ss_session_status status[STATUSES];
    ss_session session;
    ss_samples echo;
    ss_figures figures;
    assert_true(ss_samples_init(&echo, 1));
    make_session(&session, status, &echo, tick, TICKS);
    assert_true(ss_figures_compute(&session, &figures));
    /* Statuses 8 to 96 lie within; windows end at 24 s (96) and 14 s (56). */
    assert_int_equal(figures.periods[0], 250 * 88);
    assert_int_equal(figures.missed[0], 88);
    assert_int_equal(figures.forces[0], 249 * 88);
    assert_int_equal(figures.step.count, 125 * 88);
    assert_int_equal(figures.window_count, 2);
    assert_equal_double(figures.haptic.p50, 56.0); /* the lower of two is their median here */
    assert_equal_double(figures.haptic.max, 96.3);
    /* The bare loop was i/1000 us late in second i: windows 4..14 s and 14..24 s. */
    assert_equal_double(figures.bare_loop.p50, 9.0);
    assert_equal_double(figures.bare_loop.max, 24.0);
    assert_int_equal(figures.bare_loop.count, 20000);
    assert_int_equal(figures.wrong_sums, 0);
    assert_int_equal(figures.statuses_lost, 0);
    ss_figures_fini(&figures);
    ss_samples_fini(&echo);
}

TEST(sums_that_do_not_add_up_are_found)
{
    static ss_bare_tick tick[100];
    static ss_session_status status[STATUSES];
    ss_session session;
    ss_samples echo;
    ss_figures figures;
    assert_true(ss_samples_init(&echo, 1));
    make_session(&session, status, &echo, tick, 100);
    status[3].of.probe_forces[0] -= 1;  /* before the run */
    status[50].of.probe_missed[7] += 1; /* a probe that nobody uses */
    for (int i = 60; i < STATUSES; ++i) {
        status[i].of.seq += 4; /* four were lost */
    }
    status[70].of.verdict = 2;
    snprintf(status[70].reason, sizeof status[70].reason, "slow");
    assert_true(ss_figures_compute(&session, &figures));
    assert_int_equal(figures.wrong_sums, 2);
    assert_int_equal(figures.statuses_lost, 4);
    assert_int_equal(figures.worst_verdict, 2);
    assert_string_equal(figures.reason, "slow");
    session.status_count = 9; /* one within the run */
    assert_false(ss_figures_compute(&session, &figures));
    ss_samples_fini(&echo);
}

TEST(only_first_answers_within_the_run_count)
{
    ss_session session = {.begin_ns = SECOND_NS, .end_ns = 2LL * SECOND_NS};
    ss_figures figures = {.window_count = 0};
    softsim_error error = {.status = SOFTSIM_OK};
    const char *path = write_text("answers.csv", "pose_seq,pose_utime,probe,fx,latency_us\n"
                                                 "1,999999,0,0,11\n" /* before the run */
                                                 "2,1000000,0,0,12\n"
                                                 "2,1000000,0,0,99\n" /* a second answer */
                                                 "1,1000500,3,0,13\n" /* another probe */
                                                 "9,1000500,8,0,98\n" /* no such probe */
                                                 "4,2000000,0,0,14\n"
                                                 "3,1500000,0,0,97\n" /* late, superseded */
                                                 "5,2000001,0,0,96\n");
    snprintf(session.answers, sizeof session.answers, "%s", path);
    assert_int_equal(ss_figures_read_answers(&session, &figures, &error), SOFTSIM_OK);
    assert_int_equal(figures.pose_to_force.count, 3);
    assert_equal_double(figures.pose_to_force.p50, 13.0);
    assert_equal_double(figures.pose_to_force.max, 14.0);
    ss_figures_fini(&figures);
    write_text("answers.csv", "pose_seq,pose_utime,probe\n1,1,0\n");
    assert_int_not_equal(ss_figures_read_answers(&session, &figures, &error), SOFTSIM_OK);
}

/* ---- reading ---- */

TEST(a_bridges_log_is_timed_by_its_ticks)
{
    ss_judge_log log;
    softsim_error error = {.status = SOFTSIM_OK};
    const char *path = write_text("hand.csv", "tick,x,y,z,vx,fx,fy,fz\n"
                                              "10,1,2,3,0,4,5,6\n11,1,2,4,0,7,8,9\n");
    assert_int_equal(ss_judge_load(path, 500.0, &log, &error), SOFTSIM_OK);
    assert_int_equal(log.count, 2);
    assert_equal_double(log.row[1].time_s - log.row[0].time_s, 0.002);
    assert_equal_double(log.row[1].x[2], 4.0);
    assert_equal_double(log.row[1].f[0], 7.0);
    assert_int_equal(log.row[0].flags, 0);
    assert_false(log.has_age);
    ss_judge_free(&log);
    path = write_text("hand.csv", "x,y,z,fx,fy,fz\n1,2,3,4,5,6\n");
    assert_int_not_equal(ss_judge_load(path, 500.0, &log, &error), SOFTSIM_OK);
    assert_int_equal(ss_judge_run("test", path, 500.0, 1), 2);
}

TEST(bridge_arguments_are_read_without_a_shell)
{
    char value[64];
    const char *word[3];
    const char *path = write_text("p.sh", "# X_SECOND=no\nOTHER=\"a\"\n"
                                          "KIDNEY_SECOND=\"--offset-m 0,0,1  --axes x\"\n");
    assert_true(ss_session_read_bridge(path, value, sizeof value));
    assert_string_equal(value, "--offset-m 0,0,1  --axes x");
    assert_int_equal(ss_session_split(value, word, 3), -1);
    snprintf(value, sizeof value, "  --offset-m 0,0,1 ");
    assert_int_equal(ss_session_split(value, word, 3), 2);
    assert_string_equal(word[1], "0,0,1");
    snprintf(value, sizeof value, " ");
    assert_int_equal(ss_session_split(value, word, 3), 0);

    assert_false(ss_session_read_bridge(write_text("p.sh", "A_SECOND=\"$(id)\"\n"), value, 64));
    assert_false(ss_session_read_bridge(write_text("p.sh", "A_SECOND=\"open\n"), value, 64));
    assert_false(ss_session_read_bridge(write_text("p.sh", "A_SECOND=\"long\"\n"), value, 4));
    assert_false(ss_session_read_bridge(write_text("p.sh", "_SECONDS=a\nSECOND=a\n"), value, 64));
    assert_true(ss_session_read_bridge(write_text("p.sh", "A_SECOND='a b'\n"), value, 64));
    assert_string_equal(value, "a b");
    assert_false(ss_session_read_bridge("/nowhere/p.sh", value, 64));
}

/* ---- writing ---- */

TEST(a_page_is_escaped_and_complete_or_not_there)
{
    static char text[65536];
    ss_page page;
    softsim_error error = {.status = SOFTSIM_OK};
    const char *nested = in_folder("a/b"), *path = in_folder("a/b/page.html");
    assert_int_equal(ss_report_make_folder(nested, &error), SOFTSIM_OK);
    assert_int_equal(ss_report_make_folder(nested, &error), SOFTSIM_OK);

    assert_int_equal(ss_page_open(&page, nested, "page", "<title>", &error), SOFTSIM_OK);
    ss_page_text(&page, "%s", "a < b & \"c\"");
    const char *const cell[] = {"12.5%", "<i>"};
    ss_page_table_begin(&page, 2, cell);
    ss_page_table_row(&page, 2, cell);
    char verdict[401];
    ss_row row = {.count = 0};
    memset(verdict, 'v', 400);
    verdict[400] = '\0';
    ss_row_add(&row, "%s", verdict); /* as long as an accuracy's may be */
    ss_page_table_row(&page, row.count, row.cell);
    const char *const sides[] = {"0.501 (+0.2 %)", "422 points: at least the paper's rate, Hz"};
    ss_page_table_row(&page, 2, sides); /* a figure, and a sentence that begins with one */
    ss_page_table_end(&page);
    ss_page_yardstick(&page, &(ss_yardstick){.cores = 2, .load = 0.5});
    assert_int_not_equal(access(path, F_OK), 0);
    assert_int_equal(ss_page_close(&page, &error), SOFTSIM_OK);
    read_text("a/b/page.html", text, sizeof text);
    assert_non_null(strstr(text, "<title>&lt;title&gt;</title>"));
    assert_non_null(strstr(text, "<p>a &lt; b &amp; &quot;c&quot;</p>"));
    assert_non_null(strstr(text, "<td class=\"n\">12.5%</td><td>&lt;i&gt;</td>"));
    assert_non_null(strstr(text, verdict));
    assert_non_null(strstr(text, "<td class=\"n\">0.501 (+0.2 %)</td><td>422 points"));
    assert_non_null(strstr(text, "load 0.50 in the minute before this was measured"));
    assert_non_null(strstr(text, "</html>"));
    unlink(path);

    assert_int_equal(ss_page_open(&page, nested, "page", "t", &error), SOFTSIM_OK);
    ss_page_abandon(&page);
    assert_int_not_equal(access(path, F_OK), 0);
    rmdir(nested);
    rmdir(in_folder("a"));
}

TEST(a_csv_field_is_quoted_where_it_must_be)
{
    char text[128];
    FILE *file = open_file("quote.csv");
    ss_csv_text(file, "plain: text");
    fputc(',', file);
    ss_csv_text(file, "a, \"b\"\nc");
    assert_int_equal(fclose(file), 0);
    read_text("quote.csv", text, sizeof text);
    assert_string_equal(text, "plain: text,\"a, \"\"b\"\"\nc\"");
}

/* ---- temporary folders ---- */

static void make_inner(const char *in, const char *name, bool is_folder)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", in, name);
    FILE *file = is_folder ? NULL : fopen(path, "w");
    assert_int_equal(is_folder ? mkdir(path, 0700) : fclose(file), 0);
}

TEST(temporary_folders_go_with_what_is_in_them)
{
    char one[SS_SCRATCH_PATH], other[SS_SCRATCH_PATH], kept[SS_SCRATCH_PATH], link[512];
    softsim_error error = {.status = SOFTSIM_OK};
    const char *outside = write_text("good.csv", "");
    setenv("TMPDIR", folder, 1);
    assert_int_equal(ss_scratch_make("a-1", one, &error), SOFTSIM_OK);
    assert_int_equal(ss_scratch_make("a-1", other, &error), SOFTSIM_OK);
    assert_int_equal(ss_scratch_make("a-12", kept, &error), SOFTSIM_OK);
    assert_ptr_equal(strstr(one, folder), one);
    assert_string_not_equal(one, other);
    make_inner(one, "scene.yaml", false);
    make_inner(one, "trial-abc", true);
    make_inner(one, "trial-abc/body.msh", false);
    snprintf(link, sizeof link, "%s/link", one);
    assert_int_equal(symlink(folder, link), 0);
    ss_scratch_remove(one);
    assert_int_not_equal(access(one, F_OK), 0);
    assert_int_equal(access(outside, F_OK), 0);
    make_inner(other, "scene.yaml", false);
    snprintf(link, sizeof link, "%s/a-1-abcdef", folder); /* another's, in a folder of everyone's */
    make_inner(kept, "scene.yaml", false);
    assert_int_equal(symlink(kept, link), 0);
    ss_scratch_remove_all("a-1");
    assert_int_not_equal(access(link, F_OK), 0);
    snprintf(link, sizeof link, "%s/scene.yaml", kept);
    assert_int_equal(access(link, F_OK), 0);
    ss_scratch_remove_all("a");
    assert_int_not_equal(access(other, F_OK), 0);
    assert_int_equal(access(kept, F_OK), 0);
    ss_scratch_remove(kept);
    assert_int_not_equal(access(kept, F_OK), 0);
    ss_scratch_remove("");
    unsetenv("TMPDIR");
}

TEST(temporary_folders_are_made_where_it_is_said_if_that_can_be)
{
    char path[SS_SCRATCH_PATH], far[2 * SS_SCRATCH_PATH] = "/tmp";
    softsim_error error = {.status = SOFTSIM_OK};
    while (strlen(far) < SS_SCRATCH_PATH) {
        strcat(far, "/.");
    }
    const char *const unusable[] = {far, ".", ""};
    for (size_t i = 0; i < sizeof unusable / sizeof *unusable; ++i) {
        setenv("TMPDIR", unusable[i], 1);
        assert_int_equal(ss_scratch_make("softsim-test", path, &error), SOFTSIM_OK);
        assert_ptr_equal(strstr(path, "/tmp/softsim-test-"), path);
        ss_scratch_remove(path);
        assert_int_not_equal(access(path, F_OK), 0);
    }
    setenv("TMPDIR", "/nowhere", 1);
    assert_int_equal(ss_scratch_make("softsim-test", path, &error), SOFTSIM_ERROR_FILE);
    assert_string_equal(path, "");
    assert_non_null(strstr(error.text, "/nowhere"));
    unsetenv("TMPDIR");
}

/* ---- children ---- */

static int run(const char *const *argv, double timeout_s)
{
    const ss_child_plan plan = {.name = argv[0], .argv = argv};
    return ss_child_run(&plan, timeout_s);
}

TEST(children_are_reaped_with_their_status)
{
    static const char *const three[] = {"sh", "-c", "exit 3", NULL};
    static const char *const none[] = {"/nowhere/program", NULL};
    static const char *const endless[] = {"sleep", "1000", NULL};
    static const char *const stubborn[] = {
        "sh", "-c", "trap '' TERM; echo up; while :; do sleep 1; done", NULL};
    assert_int_equal(run(three, 60.0), 3);
    assert_int_equal(run(none, 60.0), 127);
    ss_process_catch_stop(); /* not the child's, which is ended before it is the program */
    for (int i = 0; i < 20; ++i) {
        assert_int_equal(run(endless, 0.0), 128 + 15);
    }

    ss_child child;
    const ss_child_plan plan = {.name = "sh", .argv = stubborn, .has_pipe = true};
    assert_int_equal(ss_child_start(&child, &plan, NULL), SOFTSIM_OK);
    assert_true(ss_child_wait_text(&child, "up\n", 60.0));
    assert_int_equal(ss_child_stop(&child, 0.0), 128 + 9);
    assert_int_equal(ss_child_stop(&child, 0.0), 128 + 9);

    const ss_child_plan silent = {.name = "sh", .argv = three, .has_pipe = true};
    assert_int_equal(ss_child_start(&child, &silent, NULL), SOFTSIM_OK);
    assert_false(ss_child_wait_text(&child, "up\n", 60.0));
    assert_int_equal(ss_child_stop(&child, 60.0), 3);
}

/* The speed of fem is measured on what was asked for, and its figures belong together. */
TEST(speed_of_tetrahedra_adds_up)
{
    const ss_yardstick yardstick = {.fma_gflops = 100.0, .bandwidth_gb_s = 20.0};
    ss_element_speed_case what = {.model = "fem", .elements = 1500, .rounds = 3};
    ss_element_speed plain, other;
    softsim_error error = {0};
    assert_int_equal(ss_element_speed_measure(&what, &yardstick, &plain, &error), SOFTSIM_OK);
    assert_true(plain.elements > 1300 && plain.elements < 1700);
    assert_true(plain.least_ns > 0.0 && plain.ns >= plain.least_ns && plain.stable_step_s > 1e-4 &&
                plain.stable_step_s < 1e-2);
    assert_string_equal(plain.verdict, "good");
    assert_equal_double(plain.realtime,
                        0.5 * plain.stable_step_s / (1e-9 * plain.ns * plain.elements));
    assert_equal_double(plain.flop_share, 258.0 / plain.ns / 100.0);
    what.is_shuffled = what.is_viscous = true;
    assert_int_equal(ss_element_speed_measure(&what, &yardstick, &other, &error), SOFTSIM_OK);
    assert_int_equal(other.elements, plain.elements);
    assert_int_equal(other.nodes, plain.nodes);
    assert_true(other.stable_step_s < plain.stable_step_s); /* what viscosity costs */
    assert_true(other.stable_step_s > 0.9 * plain.stable_step_s);
    what.elements = 99;
    assert_int_equal(ss_element_speed_measure(&what, &yardstick, &other, &error),
                     SOFTSIM_ERROR_ARGUMENT);
}

static int remove_files(void **state)
{
    static const char *const names[] = {"answers.csv", "good.csv",   "hand.csv", "p.sh",
                                        "quote.csv",   "before.txt", "after.txt"};
    return remove_only(names, sizeof names / sizeof *names);
}

int main(void)
{
    return run_all_tests(make_folder, remove_files);
}
