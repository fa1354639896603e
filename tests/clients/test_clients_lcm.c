/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-monitor against a stand-in for the server; the arguments of all clients. */
#include "common/test.h"

#include <sys/wait.h>

#include "stand_in_fixture.h"

static process patient, asking; /* wait all the while for a server that never comes */

/* What is felt at a probe is shown to who only watches. */
SERVED_TEST(monitor_shows_force_and_indentation)
{
    const char *const bridge[] = {"softsim-bridge", "--device", "sim", "--offset-m", "0,0,0", NULL};
    const char *const monitor[] = {"softsim-monitor", NULL};
    static process hand;
    stand_in.sends_status = true;
    start_server();
    process_start(&hand, bridge, NULL);
    process_start(&child, monitor, NULL);
    const bool is_shown = process_wait_for(&child, " N, pressed in ");
    process_signal(&hand, SIGTERM);
    process_finish(&hand);
    process_signal(&child, SIGTERM);
    process_finish(&child);
    stop_server();
    if (!is_shown) {
        fail_msg("%s%s", child.out, child.err);
    }
    assert_non_null(strstr(child.out, "2.5 s good: probe 0 "));
}

SERVED_TEST(monitor_believes_only_whole_messages)
{
    const char *const argv[] = {"softsim-monitor", "--once", "--json", NULL};
    stand_in.sends_status = true;
    run_served(argv, 0);
    assert_non_null(strstr(child.out, "\"scene\": \"stand-in.yaml\", \"model\": \"linear\", "
                                      "\"reason\": \"\"}\n"));
    assert_non_null(strstr(child.out, "\"uptime_s\": 2.5"));
}

SERVED_TEST(monitor_tells_that_nobody_is_there)
{
    const char *const argv[] = {"softsim-monitor", "--duration", "0.3", NULL};
    assert_int_equal(process_run(&child, argv), 1);
    assert_non_null(strstr(child.err, "no status for 0.3"));
    assert_int_equal(process_finish(&patient), 1);
    const char *said = strstr(patient.err, "no status for 2 s; is softsimd running");
    assert_non_null(said);
    assert_null(strstr(said + 1, "no status")); /* once */
    assert_non_null(strstr(patient.err, "gave up after 10 s"));
    assert_int_equal(process_finish(&asking), 1);
    assert_non_null(strstr(asking.err, "no reply for 3 s"));
}

/* Heard to the end is 0, ended before is 1. */
SERVED_TEST(monitor_fails_when_the_server_has_ended_before_its_time)
{
    const char *const argv[] = {"softsim-monitor", "--json", "--duration", "1", NULL};
    const char *const longer[] = {"softsim-monitor", "--json", "--duration", "5", NULL};
    stand_in.sends_status = true;
    run_served(argv, 0);
    stand_in.is_stopping = false;
    start_server();
    process_start(&child, longer, NULL);
    const bool is_heard = process_wait_for(&child, "stand-in.yaml");
    stop_server();
    assert_int_equal(process_finish(&child), 1);
    assert_true(is_heard);
    assert_non_null(strstr(child.err, "no status for 2 s; is softsimd running"));
}

/* Started first and asked last: they take their time. */
static int start_patient(void **state)
{
    const char *const once[] = {"softsim-monitor", "--once", "--prefix", "NOBODY", NULL};
    const char *const pause[] = {"softsim-monitor", "--command", "pause",
                                 "--prefix",        "NOBODY",    NULL};
    process_start(&patient, once, NULL);
    process_start(&asking, pause, NULL);
    return 0;
}

static int stop_patient(void **state)
{
    process_kill(&patient);
    process_kill(&asking);
    return 0;
}

SERVED_TEST(a_machine_without_a_route_is_told)
{
    static const char *const programs[] = {"softsim-bridge --device sim --ticks 5",
                                           "softsim-monitor --once", "softsim-replay"};
    const char *log = in_folder("a.lcmlog");
    make_log(log, 3, 1);
    for (int i = 0; i < 3; ++i) {
        char command[512];
        char text[4096];
        snprintf(command, sizeof command, "unshare -n %s/%s %s 2>&1", BIN_DIR, programs[i],
                 i == 2 ? log : "");
        FILE *pipe = popen(command, "r");
        assert_non_null(pipe);
        text[fread(text, 1, sizeof text - 1, pipe)] = '\0';
        const int status = pclose(pipe);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 1);
        assert_non_null(strstr(text, "ip route add 224.0.0.0/4 dev lo"));
    }
}

SERVED_TEST(bad_arguments_are_all_named)
{
    const char *log = in_folder("a.lcmlog");
    const char *bad = in_folder("bad.lcmlog");
    make_log(log, 3, 1);
    FILE *file = fopen(bad, "w");
    assert_non_null(file);
    fputs("this is no log", file);
    fclose(file);
    const struct {
        const char *argv[12];
        const char *said;
        int lines;
    } cases[] = {
        {{"softsim-replay", log, log}, "--convert", 1},
        {{"softsim-replay", "--convert", log}, "--convert needs two files", 1},
        {{"softsim-replay", log, "--lockstep", "--speed", "2"}, "--speed", 1},
        {{"softsim-replay", log, "--repeat", "0", "--rate", "x"}, "--rate", 2},
        {{"softsim-replay", log, "--prefix", "a.*"}, "prefix", 1},
        {{"softsim-replay", log, "--prefix", ""}, "prefix", 1},
        {{"softsim-replay", bad}, "no probe poses", 2},
        {{"softsim-replay", folder}, "a folder, not a file", 1},
        {{"softsim-replay", log, "--nonsense"}, "--nonsense", 1},
        {{"softsim-replay", "--nonsense"}, "--nonsense", 1},
        {{"softsim-replay", "--nonsense", "3", "4", log}, "--nonsense", 1},
        {{"softsim-replay", log, "--repeat"}, "--repeat needs a value", 1},
        {{"softsim-bridge", "--device", "wand"}, "wand", 1},
        {{"softsim-bridge", "--device", "script"}, "--path", 1},
        {{"softsim-bridge", "--device", "sim", "--path", log}, "--path", 1},
        {{"softsim-bridge", "--device", "sim", "--delay-ticks", "2"}, "--delay-ticks", 1},
        {{"softsim-bridge", "--device", "sim", "--linear-tissue", "5", "--delay-ms", "1"},
         "--linear-tissue",
         1},
        {{"softsim-bridge", "--device", "sim", "--body", "huge", "--loss", "2"}, "--loss", 2},
        {{"softsim-bridge", "--device", "sim", "--axes", "x,y", "--offset-m", "a"},
         "--offset-m",
         2},
        {{"softsim-bridge", "--device", "script", "--path", "/nowhere/p.csv"}, "/nowhere/p.csv", 1},
        {{"softsim-monitor", "--duration", "-1"}, "--duration", 1},
        {{"softsim-monitor", "more"}, "more", 1},
        {{"softsim-monitor", "--command", "pause", "--once"}, "--command", 1},
        {{"softsim-monitor", "--command", ""}, "--command: give NAME", 1},
        {{"softsim-monitor", "--command", "set a=\x1b[2J"}, "--command: give NAME", 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const int status = process_run(&child, cases[i].argv);
        int lines = 0;
        for (const char *at = child.err; (at = strchr(at, '\n')) != NULL; ++at) {
            ++lines;
        }
        if (status != 2 || strstr(child.err, cases[i].said) == NULL || lines != cases[i].lines) {
            fail_msg("%s, case %zu: status %d: %s", cases[i].argv[0], i, status, child.err);
        }
        assert_int_equal(child.out_size, 0);
    }
    static const char *const programs[] = {"softsim-replay", "softsim-bridge", "softsim-monitor"};
    for (int i = 0; i < 3; ++i) {
        const char *const help[] = {programs[i], "--help", NULL};
        const char *const version[] = {programs[i], "--version", NULL};
        assert_int_equal(process_run(&child, help), 0);
        assert_non_null(strstr(child.out, "--lcm-url"));
        assert_int_equal(process_run(&child, version), 0);
        assert_non_null(strstr(child.out, programs[i]));
    }
}

int main(void)
{
    return process_run_tests(start_patient, stop_patient);
}
