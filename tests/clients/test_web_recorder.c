/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-web's recorder without a network, on a disk of ours: nothing is lost without being
 * counted, nothing grows without a limit. */
#include "common/test.h"

#include <errno.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/folder_fixture.h"
#include "recorder.h"
#include "softsim/log.h"

enum { MESSAGE = 1000, ROOM = 1 << 16 };

/* ---- a disk that stands still, or is full ---- */

static sem_t stalled, going_on;
static atomic_bool is_slow, is_full;

int __real_fflush(FILE *file);
int __wrap_fflush(FILE *file);

int __wrap_fflush(FILE *file)
{
    if (atomic_exchange(&is_slow, false)) {
        sem_post(&stalled);
        while (sem_wait(&going_on) != 0) {
        }
    }
    if (atomic_exchange(&is_full, false)) {
        errno = ENOSPC;
        return EOF;
    }
    return __real_fflush(file);
}

/* ---- a clock that stands ---- */

time_t __wrap_time(time_t *out);

/* Or was set back between two recordings. */
time_t __wrap_time(time_t *out)
{
    const time_t now = 1700000000;
    if (out != NULL) {
        *out = now;
    }
    return now;
}

/* ---- a recorder ---- */

static ss_recorder *recorder;
static char *told;

static void open_recorder(ss_recorder_config config)
{
    softsim_error error = {.status = SOFTSIM_OK};
    config.folder = folder;
    config.ring_bytes = ROOM;
    config.most_bytes = config.most_bytes > 0 ? config.most_bytes : 1 << 20;
    config.most_in_all = config.most_in_all > 0 ? config.most_in_all : 1 << 20;
    config.most_files = config.most_files > 0 ? config.most_files : 4;
    assert_int_equal(ss_recorder_open(&config, &recorder, &error), SOFTSIM_OK);
}

static int close_recorder(void **state)
{
    ss_recorder_close(&recorder, NULL);
    free(told);
    told = NULL;
    return remove_folder(state);
}

static int begin(void **state)
{
    make_folder(state);
    sem_init(&stalled, 0, 0);
    sem_init(&going_on, 0, 0);
    return 0;
}

static void tell(void)
{
    size_t size = 0;
    free(told);
    told = NULL;
    FILE *out = open_memstream(&told, &size);
    assert_non_null(out);
    ss_recorder_tell(recorder, out);
    fclose(out);
}

/* Until it says `part`. */
static void expect(const char *part)
{
    do {
        tell();
        usleep(1000);
    } while (strstr(told, part) == NULL);
}

static void start(void)
{
    ss_recorder_want(recorder, true);
    expect("\"is_recording\": true");
}

static void stop(void)
{
    ss_recorder_want(recorder, false);
    expect("\"is_recording\": false");
}

/* Number `n`, as its time and all of its bytes tell. */
static void take(int n)
{
    uint8_t data[MESSAGE];
    memset(data, n & 255, sizeof data);
    ss_recorder_take(recorder, n, "SOFTSIM_PROBE_0", data, MESSAGE);
}

/* How many are in the last finished recording, whole; numbers grow. */
static int count_recorded(void)
{
    char name[128];
    const char *last = told, *next = told;
    while ((next = strstr(next + 1, "\"softsim-")) != NULL) {
        last = next;
    }
    assert_int_equal(sscanf(last, "\"%127[^\"]", name), 1);
    const char *path = ss_recorder_path(recorder, name);
    assert_non_null(path);
    softsim_log *log = NULL;
    softsim_log_event event;
    softsim_error error = {.status = SOFTSIM_OK};
    int count = 0;
    int64_t before = -1;
    assert_int_equal(softsim_log_open(path, &log, &error), SOFTSIM_OK);
    softsim_log_result result;
    while ((result = softsim_log_next(log, &event)) == SOFTSIM_LOG_EVENT) {
        assert_string_equal(event.channel, "SOFTSIM_PROBE_0");
        assert_int_equal(event.data_size, MESSAGE);
        for (int i = 0; i < MESSAGE; ++i) {
            assert_int_equal(event.data[i], event.utime_us & 255);
        }
        assert_true(event.utime_us > before);
        before = event.utime_us;
        ++count;
    }
    assert_int_equal(result, SOFTSIM_LOG_END);
    softsim_log_close(&log);
    return count;
}

/* ---- claims ---- */

/* The disk stands still with all that it has been given; whoever brings more does not wait. */
TEST_WITH(what_a_slow_disk_loses_is_counted, begin, close_recorder)
{
    enum { MESSAGES = 2000 };
    open_recorder((ss_recorder_config){.most_bytes = 1 << 24, .most_in_all = 1 << 24});
    start();
    atomic_store(&is_slow, true);
    int sent = 0;
    while (sem_trywait(&stalled) != 0) { /* until it flushes what has gathered */
        take(sent++);
        usleep(100);
    }
    for (int n = 0; n < MESSAGES; ++n) {
        take(sent++);
    }
    ss_recorder_want(recorder, false);
    sem_post(&going_on);
    expect("\"is_recording\": false");
    const char *fault = strstr(told, "\"fault\": \"");
    int lost = 0, told_lost = 0;
    assert_int_equal(sscanf(fault, "\"fault\": \"%d messages are missing in it", &lost), 1);
    assert_int_equal(sscanf(strstr(told, "\"lost\": "), "\"lost\": %d", &told_lost), 1);
    assert_int_equal(lost, told_lost);
    assert_true(lost > MESSAGES - ROOM / MESSAGE && lost < sent);
    assert_int_equal(count_recorded(), sent - lost);
}

/* Records of every alignment over the end of the ring, in order and whole. */
TEST_WITH(all_of_a_recording_is_there_when_the_disk_keeps_up, begin, close_recorder)
{
    enum { MESSAGES = 500, AT_ONCE = 20 };
    open_recorder((ss_recorder_config){0});
    take(0); /* before it begins: of no recording */
    for (int k = 0; k < 2; ++k) {
        start();
        for (int n = 0; n < MESSAGES; ++n) {
            take(1 + n);
            if (n % AT_ONCE == 0) {
                usleep(30000);
            }
        }
        stop();
        int lost = -1;
        assert_int_equal(sscanf(strstr(told, "\"lost\": "), "\"lost\": %d", &lost), 1);
        assert_int_equal(count_recorded(), MESSAGES - lost);
    }
}

static void start_with(int messages)
{
    start();
    for (int n = 0; n < messages; ++n) {
        take(n);
    }
}

TEST_WITH(a_recording_ends_at_its_limit_and_the_next_begins, begin, close_recorder)
{
    open_recorder((ss_recorder_config){.most_bytes = 10 * (MESSAGE + 28 + 15)});
    for (int k = 0; k < 2; ++k) {
        start_with(30);
        expect("the most that one recording may have");
        assert_non_null(strstr(told, "\"is_recording\": false"));
        assert_int_equal(count_recorded(), 10);
    }
}

TEST_WITH(all_recordings_together_are_bounded_and_none_is_removed, begin, close_recorder)
{
    open_recorder((ss_recorder_config){.most_in_all = 25 * (MESSAGE + 28 + 15)});
    for (int k = 0; k < 2; ++k) {
        start_with(10);
        stop();
        assert_int_equal(count_recorded(), 10);
    }
    start_with(10);
    expect("as large as they may be");
    assert_int_equal(count_recorded(), 5);
    ss_recorder_want(recorder, true);
    expect("restart softsim-web");
    assert_non_null(strstr(told, "-1.lcmlog"));
    assert_non_null(strstr(told, "-3.lcmlog"));
    assert_null(strstr(told, "-4.lcmlog"));
}

TEST_WITH(so_many_files_and_no_more, begin, close_recorder)
{
    open_recorder((ss_recorder_config){.most_files = 2});
    for (int k = 0; k < 2; ++k) {
        start();
        stop();
    }
    ss_recorder_want(recorder, true);
    expect("2 recordings are enough for one run");
}

/* Again and again: what is not freed, the address sanitizer tells. */
TEST_WITH(a_folder_that_is_gone_is_named_and_nothing_kept, begin, close_recorder)
{
    open_recorder((ss_recorder_config){0});
    rmdir(folder);
    for (int k = 0; k < 3; ++k) {
        const uint64_t version = ss_recorder_version(recorder);
        ss_recorder_want(recorder, true);
        while (ss_recorder_version(recorder) == version) {
            usleep(1000);
        }
        expect(folder);
        assert_non_null(strstr(told, "\"is_recording\": false"));
        assert_non_null(strstr(told, "\"files\": []"));
    }
    assert_int_equal(mkdir(folder, 0700), 0);
    start();
    stop();
}

/* A run that ends, in the middle of a recording or after one, leaves a temporary folder empty. */
TEST_WITH(temporary_recordings_go_at_the_end, begin, close_recorder)
{
    open_recorder((ss_recorder_config){.is_temporary = true});
    for (int k = 0; k < 2; ++k) {
        start();
        take(k);
    }
    ss_recorder_close(&recorder, NULL);
    assert_int_equal(rmdir(folder), 0);
    assert_int_equal(mkdir(folder, 0700), 0);
}

/* What the page names as kept is kept; what it could offer goes with the folder. */
TEST_WITH(what_the_disk_did_not_take_stays_where_it_is_said, begin, close_recorder)
{
    char part[256];
    open_recorder((ss_recorder_config){.is_temporary = true});
    start();
    take(0);
    stop();
    start();
    atomic_store(&is_full, true);
    do {
        take(1);
        usleep(1000);
        tell();
    } while (strstr(told, "\"is_recording\": true") != NULL);
    const char *at = strstr(told, "; what was recorded before is in ");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "; what was recorded before is in %255[^\" ;]", part), 1);
    assert_non_null(strstr(part, "-2.lcmlog.part"));
    ss_recorder_close(&recorder, NULL);
    assert_int_equal(access(part, F_OK), 0);
    assert_int_equal(unlink(part), 0);
    assert_int_equal(rmdir(folder), 0); /* the finished one has gone */
    assert_int_equal(mkdir(folder, 0700), 0);
}

/* Nobody is left to ask for the fault then. */
TEST_WITH(what_the_disk_does_not_take_at_the_end_is_told_by_the_close, begin, close_recorder)
{
    softsim_error error = {.status = SOFTSIM_OK};
    open_recorder((ss_recorder_config){0});
    start();
    take(0);
    stop();
    start();
    take(1);
    atomic_store(&is_full, true);
    ss_recorder_close(&recorder, &error);
    assert_int_equal(error.fault_count, 1);
    assert_int_equal(error.status, SOFTSIM_ERROR_FILE);
    assert_non_null(strstr(error.text, "-2.lcmlog: cannot write: "));
    assert_non_null(strstr(error.text, "-2.lcmlog.part"));
}

/* Another softsim-web on the folder, in the same second. */
TEST_WITH(no_recording_of_another_is_replaced, begin, close_recorder)
{
    open_recorder((ss_recorder_config){0});
    start_with(3);
    stop();
    start_with(5); /* goes on while the other's come and go */
    ss_recorder *first = recorder;
    open_recorder((ss_recorder_config){0});
    for (int k = 0; k < 2; ++k) {
        start_with(7);
        stop();
        assert_int_equal(count_recorded(), 7);
    }
    assert_non_null(strstr(told, "\"files\": [\"softsim-20231114-221320-3.lcmlog\", "
                                 "\"softsim-20231114-221320-4.lcmlog\"]"));
    ss_recorder_close(&recorder, NULL);
    recorder = first;
    stop();
    assert_int_equal(count_recorded(), 5);
    start_with(9);
    stop();
    assert_int_equal(count_recorded(), 9);
    assert_non_null(strstr(told, "\"files\": [\"softsim-20231114-221320-1.lcmlog\", "
                                 "\"softsim-20231114-221320-2.lcmlog\", "
                                 "\"softsim-20231114-221320-5.lcmlog\"]"));
    static const int size[] = {3, 5, 7, 7, 9};
    for (int k = 0; k < 5; ++k) {
        struct stat found;
        char name[64];
        snprintf(name, sizeof name, "softsim-20231114-221320-%d.lcmlog", k + 1);
        assert_int_equal(stat(in_folder(name), &found), 0);
        assert_int_equal(found.st_size, size[k] * (MESSAGE + 28 + 15));
    }
}

/* A copy that a user puts there while it is recorded. */
TEST_WITH(what_came_to_the_name_meanwhile_stays, begin, close_recorder)
{
    static const char name[] = "softsim-20231114-221320-1.lcmlog";
    char kept[8];
    open_recorder((ss_recorder_config){0});
    start_with(3);
    write_text(name, "mine");
    stop();
    assert_non_null(strstr(told, "; it is in "));
    assert_non_null(strstr(told, "-1.lcmlog.part"));
    assert_non_null(strstr(told, "\"files\": []"));
    read_text(name, kept, sizeof kept);
    assert_string_equal(kept, "mine");
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
