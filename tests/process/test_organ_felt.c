/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* From a bare OBJ to a felt organ with the README's three commands, and hands that miss. */
#include "common/test.h"

#include <math.h>

#include "common/effort.h"
#include "daemon_fixture.h"

/* In another unit than its own, so that nothing is known but the shape. */
static const char *bare_obj(void)
{
    const char *const argv[] = {
        "softsim-mesh",        "generate", "kidney", "--points", "250", "--units", "dm", "--out",
        in_folder("bare.obj"), NULL};
    if (process_run(&other, argv) != 0) {
        fail_msg("%s", other.err);
    }
    return in_folder("bare.obj");
}

/* What was felt, beside what the scene's two presses said of rest: both of a depth from the first
 * touch. A force grows with depth at a power from 1 to 2, on the power that the two presses have
 * between them; in motion it is more, by what the scene says or a hand that moves faster adds. A
 * client whose forces the machine holds up for 20 ms goes on by the felt stiffness meanwhile, up to
 * what its hand moved: how much that is says nothing of the scene. */
static void expect_between(double force, double indentation_mm, bool is_held_up)
{
    const char *said = strstr(other.out, "pressed and held: "),
               *deep = strstr(other.out, " went; ");
    double first[2], second[2];
    assert_true(said != NULL && deep != NULL);
    assert_int_equal(
        sscanf(said, "pressed and held: %lf N at %lf mm of indentation", &first[0], &first[1]), 2);
    assert_int_equal(sscanf(deep, " went; %lf N at %lf mm", &second[0], &second[1]), 2);
    const double power = log(second[0] / first[0]) / log(second[1] / first[1]);
    const double at_rest = first[0] * pow(indentation_mm / first[1], power);
    print_message("%.3f N felt at %.2f mm, %.3f N at rest\n", force, indentation_mm, at_rest);
    assert_true(power > 0.8 && power < 2.2);
    assert_true(force > 0.7 * at_rest && (is_held_up || force < 2.0 * at_rest));
}

TEST_WITH(a_bare_obj_is_felt_after_three_commands, make_folder, tear_down)
{
    const char *obj = bare_obj(), *scene = in_folder("organ.yaml");
    const char *const write[] = {"softsim-mesh", "scene", obj,   "--tissue",
                                 "kidney",       "--out", scene, NULL};
    const char *const feel[] = {"softsim-bridge",           "--device", "sim", "--duration",
                                FULL_IN_LONG_RUN("8", "2"), NULL};
    if (process_run(&other, write) != 0) {
        fail_msg("%s%s", other.out, other.err);
    }
    assert_non_null(strstr(other.out, ", in dm (judged by size, "));
    start_daemon(scene, NULL);
    if (process_run(&client, feel) != 0) {
        fail_msg("%s%s", client.out, client.err);
    }
    double share = 0.0, force = 0.0, indentation_mm = 0.0, latency_us = 0.0;
    const char *contact = strstr(client.out, "contact "), *peak = strstr(client.out, "peak force "),
               *latency = strstr(client.out, "latency_us ");
    assert_true(contact != NULL && peak != NULL && latency != NULL);
    assert_int_equal(sscanf(latency, "latency_us mean %*f max %lf", &latency_us), 1);
    assert_int_equal(sscanf(contact, "contact %lf", &share), 1);
    assert_int_equal(
        sscanf(peak, "peak force %lf N at %lf mm of indentation\n", &force, &indentation_mm), 2);
    print_message("%s%s", client.out, client.err);
    assert_true(share > 0.0 && force > 0.0);
    expect_between(force, indentation_mm, latency_us > 20e3);
    assert_null(strstr(client.err, "inside the tissue"));
    assert_int_equal(stop_daemon(), 0);
}

TEST_WITH(a_bridge_that_misses_says_by_how_much, make_folder, tear_down)
{
    const char *const miss[] = {"softsim-bridge", "--device", "sim", "--offset-m",
                                "0,0,0.1",        "--ticks",  "700", NULL};
    const char *const nobody[] = {"softsim-bridge", "--device", "sim", "--probe", "5", NULL};
    start_kidney();
    if (process_run(&client, miss) != 0) {
        fail_msg("%s%s", client.out, client.err);
    }
    /* The hand goes to z = 92 mm and the kidney's top is at 22 to 23 mm. */
    const char *said = strstr(client.err, "the tool has touched nothing");
    assert_non_null(said);
    double left_mm = 0.0;
    const char *at = strstr(said, "its centre was ");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "its centre was %lf mm", &left_mm), 1);
    assert_true(left_mm > 68.0 && left_mm < 72.0);
    assert_int_equal(process_run(&client, nobody), 1);
    assert_non_null(strstr(client.err, "no tool for this probe"));
    assert_int_equal(stop_daemon(), 0);

    const char *const silent[] = {"--set", kidney_mesh(), "--set", "publish.mesh_rate_hz=0", NULL};
    const char *const plain[] = {"softsim-bridge", "--device", "sim", "--ticks", "50", NULL};
    start_daemon(KIDNEY, silent);
    assert_int_equal(process_run(&client, plain), 1);
    assert_non_null(strstr(client.err, "publishes no mesh"));
    assert_int_equal(stop_daemon(), 0);
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
