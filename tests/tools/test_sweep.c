/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * tools/bench/sweep: every run is done once, whatever the number of processes and ranks; a crash,
 * an error and a time-out lose one run each; a sweep that was killed, also in the middle of a
 * record, goes on without doing again what it has; parts of another sweep are refused.
 */
#include "common/test.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bench/core/sweep.h"
#include "common/folder_fixture.h"
#include "process.h"

enum { RUNS = 12, CRASHES = 3, FAILS = 5, HANGS = 7 };

/* What runs do, and a file in which each leaves a byte. */
typedef struct deed {
    const char *salt;
    bool is_bad; /* some runs are lost */
    useconds_t pause_us;
} deed;

static void label(const void *context, int32_t index, char out[SS_SWEEP_NAME_SIZE])
{
    const deed *what = context;
    snprintf(out, SS_SWEEP_NAME_SIZE, "%s %d", what->salt, index);
}

static softsim_status run(const void *context, int32_t index, FILE *out, softsim_error *error)
{
    const deed *what = context;
    FILE *log = fopen(in_folder("log"), "ae");
    fprintf(log, "%c", 'a' + index);
    fclose(log);
    usleep(what->pause_us);
    if (what->is_bad && index == CRASHES) {
        fprintf(out, "half a row");
        fflush(out);
        raise(SIGKILL);
    }
    if (what->is_bad && index == FAILS) {
        fprintf(out, "a row of which nothing is kept");
        softsim_error_add(error, SOFTSIM_ERROR_SCENE, "no such thing");
        return SOFTSIM_ERROR_SCENE;
    }
    if (what->is_bad && index == HANGS) {
        pause();
    }
    fprintf(out, "row %d\nsecond, of %d\n", index, index * index);
    return SOFTSIM_OK;
}

static const deed good = {.salt = "good"};

static ss_sweep sweep_of(const deed *what, int32_t jobs)
{
    return (ss_sweep){.folder = folder,
                      .name = "test",
                      .count = RUNS,
                      .jobs = jobs,
                      .timeout_s = 0.5,
                      .context = what,
                      .label = label,
                      .run = run};
}

static const char *const left[] = {"test.0.part", "test.1.part", "test.2.part", "test.3.part",
                                   "log"};
enum { LEFT_COUNT = sizeof left / sizeof *left };

static void remove_all(void)
{
    for (int k = 0; k < LEFT_COUNT; ++k) {
        unlink(in_folder(left[k]));
    }
}

/* Letters of the runs that were begun, in order. */
static void read_log(char out[256])
{
    FILE *file = fopen(in_folder("log"), "re");
    out[file != NULL ? fread(out, 1, 255, file) : 0] = '\0';
    if (file != NULL) {
        fclose(file);
    }
}

static int32_t count_in_log(char letter)
{
    char log[256];
    int32_t count = 0;
    read_log(log);
    for (const char *at = log; *at != '\0'; ++at) {
        count += *at == letter;
    }
    return count;
}

static void assert_good_results(const ss_sweep_result *result)
{
    assert_true(result->is_complete);
    assert_int_equal(result->count, RUNS);
    assert_int_equal(result->lost, 0);
    for (int32_t i = 0; i < RUNS; ++i) {
        char text[64];
        snprintf(text, sizeof text, "row %d\nsecond, of %d\n", i, i * i);
        assert_false(result->run[i].is_lost);
        assert_string_equal(result->run[i].text, text);
    }
}

/* Executes and expects it to go well. */
static void execute(const deed *what, int32_t jobs, ss_sweep_result *result)
{
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_sweep sweep = sweep_of(what, jobs);
    const softsim_status status = ss_sweep_execute(&sweep, result, &error);
    if (status != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
}

TEST(every_run_is_done_once_whatever_the_jobs)
{
    for (int32_t jobs = 1; jobs <= 5; jobs += 2) {
        ss_sweep_result result;
        remove_all();
        execute(&good, jobs, &result);
        assert_good_results(&result);
        assert_int_equal(result.resumed, 0);
        for (int32_t i = 0; i < RUNS; ++i) {
            assert_int_equal(count_in_log((char)('a' + i)), 1);
        }
        ss_sweep_result_fini(&result);
    }
}

TEST(a_lost_run_is_a_result_with_its_reason)
{
    static const deed bad = {.salt = "bad", .is_bad = true};
    ss_sweep_result result;
    remove_all();
    execute(&bad, 2, &result);
    assert_true(result.is_complete);
    assert_int_equal(result.lost, 3);
    assert_true(result.run[CRASHES].is_lost);
    assert_string_equal(result.run[CRASHES].text, "crashed: Killed");
    assert_true(result.run[FAILS].is_lost);
    assert_string_equal(result.run[FAILS].text, "no such thing");
    assert_true(result.run[HANGS].is_lost);
    assert_string_equal(result.run[HANGS].text, "timed out after 0.5 s");
    assert_string_equal(result.run[RUNS - 1].text, "row 11\nsecond, of 121\n");
    ss_sweep_result_fini(&result);
    /* What is lost stays lost, and nothing is run again. */
    execute(&bad, 2, &result);
    assert_int_equal(result.resumed, RUNS);
    assert_int_equal(result.lost, 3);
    assert_int_equal(count_in_log('a' + CRASHES), 1);
    ss_sweep_result_fini(&result);
}

TEST(a_killed_sweep_goes_on)
{
    static const deed slow = {.salt = "slow", .pause_us = 20000};
    ss_sweep_result result;
    char log[256];
    remove_all();
    const pid_t pid = fork();
    if (pid == 0) {
        execute(&slow, 2, &result);
        _exit(0);
    }
    do {
        usleep(1000);
        read_log(log);
    } while (strlen(log) < RUNS / 2);
    kill(pid, SIGKILL);
    waitpid(pid, NULL, 0);
    execute(&slow, 2, &result);
    assert_good_results(&result);
    assert_in_range(result.resumed, 1, RUNS - 1);
    /* At most the two that were under way are run twice. */
    read_log(log);
    assert_in_range(strlen(log), RUNS, RUNS + 2);
    ss_sweep_result_fini(&result);
}

/* As a terminal does it: to the sweep and to its runs at once. */
TEST(an_interrupted_sweep_loses_no_run)
{
    static const deed slow = {.salt = "slow", .pause_us = 20000};
    ss_sweep_result result;
    char log[256];
    int status = 0;
    remove_all();
    const pid_t pid = fork();
    if (pid == 0) {
        softsim_error error = {.status = SOFTSIM_OK};
        const ss_sweep sweep = sweep_of(&slow, 2);
        setpgid(0, 0);
        ss_process_catch_stop();
        _exit(ss_sweep_execute(&sweep, &result, &error) == SOFTSIM_OK ? 0 : 1);
    }
    do {
        usleep(1000);
        read_log(log);
    } while (strlen(log) < RUNS / 2);
    kill(-pid, SIGINT);
    waitpid(pid, &status, 0);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 1);
    execute(&slow, 2, &result);
    assert_good_results(&result);
    ss_sweep_result_fini(&result);
}

TEST(a_torn_record_is_run_again)
{
    ss_sweep_result result;
    struct stat whole;
    const char *path = in_folder("test.0.part");
    remove_all();
    execute(&good, 1, &result);
    ss_sweep_result_fini(&result);
    assert_int_equal(stat(path, &whole), 0);
    /* Every length of the last two records, and of the head. */
    for (off_t cut = 1; cut < 90; cut += 4) {
        assert_int_equal(truncate(path, whole.st_size - cut), 0);
        execute(&good, 1, &result);
        assert_good_results(&result);
        assert_in_range(result.resumed, RUNS - 3, RUNS - 1);
        ss_sweep_result_fini(&result);
        assert_int_equal(truncate(path, cut < 40 ? cut : 0), 0);
        execute(&good, 1, &result);
        assert_good_results(&result);
        assert_int_equal(result.resumed, 0);
        ss_sweep_result_fini(&result);
    }
    /* A byte of a text is not what was written. */
    FILE *file = fopen(path, "r+e");
    assert_non_null(file);
    fseek(file, -3, SEEK_END);
    fputc('x', file);
    fclose(file);
    execute(&good, 1, &result);
    assert_good_results(&result);
    assert_int_equal(result.resumed, RUNS - 1);
    ss_sweep_result_fini(&result);
}

TEST(another_sweep_is_refused)
{
    static const deed other = {.salt = "other"};
    ss_sweep_result result;
    remove_all();
    execute(&good, 1, &result);
    ss_sweep_result_fini(&result);
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_sweep sweep = sweep_of(&other, 1);
    assert_int_equal(ss_sweep_execute(&sweep, &result, &error), SOFTSIM_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "test.0.part"));
    assert_int_equal(error.fault_count, 1);
    ss_sweep_result_fini(&result);
}

TEST(parts_are_removed_only_when_all_is_done)
{
    ss_sweep_result result;
    const char *path = in_folder("test.0.part");
    remove_all();
    execute(&good, 1, &result);
    const ss_sweep sweep = sweep_of(&good, 1);
    result.is_complete = false;
    ss_sweep_forget(&sweep, &result);
    assert_int_equal(access(path, F_OK), 0);
    result.is_complete = true;
    ss_sweep_forget(&sweep, &result);
    assert_int_not_equal(access(path, F_OK), 0);
    ss_sweep_result_fini(&result);
}

/* Rank `rank` of three, as Open MPI tells a process. */
static pid_t start_rank(const deed *what, int rank)
{
    const pid_t pid = fork();
    if (pid == 0) {
        char text[16];
        ss_sweep_result result;
        snprintf(text, sizeof text, "%d", rank);
        setenv("OMPI_COMM_WORLD_RANK", text, 1);
        setenv("OMPI_COMM_WORLD_SIZE", "3", 1);
        setenv("PMIX_NAMESPACE", what->pause_us > 0 ? "second" : "first", 1);
        execute(what, 1, &result);
        if (result.is_complete != (rank == 0)) {
            _exit(1);
        }
        if (rank == 0) {
            assert_good_results(&result);
        }
        _exit(0);
    }
    return pid;
}

TEST(ranks_share_the_runs)
{
    remove_all();
    pid_t pid[3];
    for (int rank = 0; rank < 3; ++rank) {
        pid[rank] = start_rank(&good, rank);
    }
    for (int rank = 0; rank < 3; ++rank) {
        int status = 0;
        waitpid(pid[rank], &status, 0);
        assert_true(WIFEXITED(status));
        assert_int_equal(WEXITSTATUS(status), 0);
    }
    for (int32_t i = 0; i < RUNS; ++i) {
        assert_int_equal(count_in_log((char)('a' + i)), 1);
    }
    /* The same sweep by one process finds all of them done. */
    ss_sweep_result result;
    execute(&good, 1, &result);
    assert_good_results(&result);
    assert_int_equal(result.resumed, RUNS);
    ss_sweep_result_fini(&result);
}

TEST(rank_0_waits_for_ranks_that_have_not_begun)
{
    remove_all();
    const pid_t first = start_rank(&good, 0);
    const pid_t second = start_rank(&good, 1);
    waitpid(second, NULL, 0);
    int status = 0;
    usleep(300000);
    assert_int_equal(waitpid(first, &status, WNOHANG), 0);
    const pid_t third = start_rank(&good, 2);
    waitpid(third, NULL, 0);
    waitpid(first, &status, 0);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}

static int remove_sweep(void **state)
{
    return remove_only(left, LEFT_COUNT);
}

int main(void)
{
    return run_all_tests(make_folder, remove_sweep);
}
