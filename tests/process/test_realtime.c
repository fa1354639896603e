/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The real-time rule, enforced: after start, the simulation and haptic threads never allocate,
 * lock, print or do I/O. The daemon runs under a preloaded counter while a log is played to it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "process.h"

#define SCENES SOURCE_DIR "/server/scenes/"

static long counted(const char *report, const char *name)
{
    char line[128], key[64];
    long value = -1, found = -1;
    FILE *file = fopen(report, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) {
        if (sscanf(line, "%63s %ld", key, &value) == 2) {
            if (strcmp(key, name) == 0) {
                found = value;
            } else if (strcmp(key, "total") != 0 && strcmp(key, "threads") != 0) {
                print_message("real-time threads called %s %ld times\n", key, value);
            }
        }
    }
    fclose(file);
    return found;
}

static void run_daemon(const char *report, const char *probe)
{
    char preload[512], where[512];
    snprintf(preload, sizeof preload, "LD_PRELOAD=%s", RT_GUARD);
    snprintf(where, sizeof where, "RT_GUARD_REPORT=%s", report);
    const char *const environment[] = {preload, where, probe, NULL};
    const char *const argv[] = {"softsimd", SCENES "kidney.yaml", NULL};
    static process daemon_process, client;
    process_start(&daemon_process, argv, environment);
    assert_true(process_wait_for(&daemon_process, "softsimd: ready"));
    const char *const replay[] = {"softsim-replay", SCENES "kidney-poke.lcmlog", NULL};
    if (process_run(&client, replay) != 0) {
        fail_msg("replay: %s%s", client.out, client.err);
    }
    process_signal(&daemon_process, SIGTERM);
    assert_int_equal(process_finish(&daemon_process), 0);
}

static void loops_neither_allocate_nor_lock_nor_print(void **state)
{
    (void)state;
    char report[] = "/tmp/softsim-guard-XXXXXX";
    close(mkstemp(report));
    run_daemon(report, NULL);
    assert_int_equal(counted(report, "threads"), 3); /* both loops were seen */
    assert_int_equal(counted(report, "total"), 0);
    unlink(report);
}

static void the_guard_can_see(void **state)
{
    (void)state;
    char report[] = "/tmp/softsim-guard-XXXXXX";
    close(mkstemp(report));
    run_daemon(report, "RT_GUARD_PROBE=1");
    assert_true(counted(report, "total") >= 2);
    unlink(report);
}

int main(void)
{
    if (!process_isolate()) {
        fprintf(stderr, "skipped: no private network namespace allowed here\n");
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loops_neither_allocate_nor_lock_nor_print),
        cmocka_unit_test(the_guard_can_see),
    };
    return cmocka_run_group_tests_name("realtime", tests, NULL, NULL);
}
