/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The real-time rule, enforced: after start, the simulation and haptic threads never allocate,
 * lock, print or do I/O. The daemon runs under a preloaded counter while a log is played to it.
 */
#include "common/test.h"

#include <glob.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/effort.h"
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

/* `speed`: of the log, which holds a press; the loops keep their own time. */
static void run_daemon(const char *report, const char *probe, const char *speed)
{
    char preload[512], where[512];
    snprintf(preload, sizeof preload, "LD_PRELOAD=%s", RT_GUARD);
    snprintf(where, sizeof where, "RT_GUARD_REPORT=%s", report);
    const char *const environment[] = {preload, where, probe, NULL};
    const char *const argv[] = {"softsimd", SCENES "kidney.yaml", NULL};
    static process daemon_process, client;
    process_start(&daemon_process, argv, environment);
    assert_true(process_wait_for(&daemon_process, "softsimd: ready"));
    const char *const replay[] = {"softsim-replay", SCENES "kidney-poke.lcmlog", "--speed", speed,
                                  NULL};
    if (process_run(&client, replay) != 0) {
        fail_msg("replay: %s%s", client.out, client.err);
    }
    process_signal(&daemon_process, SIGTERM);
    assert_int_equal(process_finish(&daemon_process), 0);
}

TEST(loops_neither_allocate_nor_lock_nor_print)
{
    char report[] = "/tmp/softsim-guard-XXXXXX";
    close(mkstemp(report));
    run_daemon(report, NULL, FULL_IN_LONG_RUN("1", "3"));
    assert_int_equal(counted(report, "threads"), 3); /* both loops were seen */
    assert_int_equal(counted(report, "total"), 0);
    unlink(report);
}

TEST(the_guard_can_see)
{
    char report[] = "/tmp/softsim-guard-XXXXXX";
    close(mkstemp(report));
    run_daemon(report, "RT_GUARD_PROBE=1", "9");
    assert_true(counted(report, "total") >= 2);
    unlink(report);
}

/* Bits of CapEff in a status file of /proc. */
static unsigned long long capabilities(const char *path)
{
    char line[256];
    unsigned long long bits = 0;
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file) != NULL) {
        (void)sscanf(line, "CapEff: %llx", &bits);
    }
    fclose(file);
    return bits;
}

/* Root's daemon keeps at most what SCHED_FIFO and locked memory need, in every thread, and has
 * both. */
TEST(root_keeps_no_capability_without_a_use)
{
    enum { NICE = 1 << 23, LOCK = 1 << 14 };
    static process daemon_process;
    const unsigned long long own = capabilities("/proc/self/status");
    if ((own & NICE) == 0 || (own & LOCK) == 0 || (own & ~(unsigned long long)(NICE | LOCK)) == 0) {
        skip();
    }
    const char *const argv[] = {"softsimd", SCENES "kidney.yaml", NULL};
    char pattern[64];
    glob_t thread;
    process_start(&daemon_process, argv, NULL);
    assert_true(process_wait_for(&daemon_process, "softsimd: ready"));
    snprintf(pattern, sizeof pattern, "/proc/%d/task/*/status", (int)daemon_process.pid);
    assert_int_equal(glob(pattern, 0, NULL, &thread), 0);
    assert_true(thread.gl_pathc >= 4);
    int fifo_count = 0;
    for (size_t i = 0; i < thread.gl_pathc; ++i) {
        int id = 0;
        assert_int_equal(capabilities(thread.gl_pathv[i]) & ~(unsigned long long)(NICE | LOCK), 0);
        assert_int_equal(sscanf(strstr(thread.gl_pathv[i], "task/"), "task/%d", &id), 1);
        fifo_count += sched_getscheduler(id) == SCHED_FIFO;
    }
    globfree(&thread);
    assert_true(fifo_count >= 3);
    process_signal(&daemon_process, SIGHUP); /* ends like SIGTERM */
    assert_int_equal(process_finish(&daemon_process), 0);
    assert_non_null(strstr(daemon_process.err, "haptic periods"));
    assert_null(strstr(daemon_process.err, "not locked"));
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
