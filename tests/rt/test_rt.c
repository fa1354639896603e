/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * rt/: what crosses between two threads is never torn and keeps its order; percentiles agree with
 * sorting; memory is counted; errors say how many more there were.
 */
#include "common/test.h"

#include <fcntl.h>
#include <float.h>
#include <math.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/effort.h"
#include "rt/arena.h"
#include "rt/clock.h"
#include "rt/each.h"
#include "rt/files.h"
#include "rt/histogram.h"
#include "rt/mailbox.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/plain.h"
#include "rt/progress.h"
#include "rt/random.h"
#include "rt/ring.h"
#include "rt/thread.h"

static softsim_status start(void *(*body)(void *), void *argument, ss_thread **out_thread)
{
    bool fifo_refused = false;
    return ss_thread_start("test", 0, SS_REALTIME_OFF, body, argument, out_thread, &fifo_refused);
}

/* ---- mailbox ---- */

enum { WORDS = 96, POSTS = 200000 };

typedef struct big_value {
    uint64_t word[WORDS];
} big_value;

TEST(mailbox_gives_nothing_before_the_first_post)
{
    ss_mailbox *mailbox = ss_mailbox_create(sizeof(int));
    assert_non_null(mailbox);
    bool is_new = true;
    assert_null(ss_mailbox_take(mailbox, &is_new));
    assert_false(is_new);
    *(int *)ss_mailbox_draft(mailbox) = 1; /* not posted yet */
    assert_null(ss_mailbox_take(mailbox, NULL));
    ss_mailbox_destroy(&mailbox);
    assert_null(mailbox);
    ss_mailbox_destroy(&mailbox);
}

TEST(mailbox_gives_the_newest_and_says_whether_it_is_new)
{
    ss_mailbox *mailbox = ss_mailbox_create(sizeof(int));
    for (int i = 1; i <= 5; ++i) {
        *(int *)ss_mailbox_draft(mailbox) = i;
        ss_mailbox_post(mailbox);
    }
    bool is_new = false;
    const int *taken = ss_mailbox_take(mailbox, &is_new);
    assert_int_equal(*taken, 5);
    assert_true(is_new);
    taken = ss_mailbox_take(mailbox, &is_new);
    assert_int_equal(*taken, 5);
    assert_false(is_new);
    /* The taken value stays the reader's while the writer goes on. */
    for (int i = 6; i <= 9; ++i) {
        *(int *)ss_mailbox_draft(mailbox) = i;
        ss_mailbox_post(mailbox);
        assert_int_equal(*taken, 5);
    }
    assert_int_equal(*(const int *)ss_mailbox_take(mailbox, &is_new), 9);
    assert_true(is_new);
    ss_mailbox_destroy(&mailbox);
}

static void *post_many(void *argument)
{
    ss_mailbox *mailbox = argument;
    for (uint64_t i = 1; i <= POSTS; ++i) {
        big_value *draft = ss_mailbox_draft(mailbox);
        for (int w = 0; w < WORDS; ++w) {
            draft->word[w] = i;
        }
        ss_mailbox_post(mailbox);
    }
    return NULL;
}

TEST(mailbox_between_two_threads_is_never_torn_and_never_goes_back)
{
    ss_mailbox *mailbox = ss_mailbox_create(sizeof(big_value));
    ss_thread *writer = NULL;
    assert_int_equal(start(post_many, mailbox, &writer), SOFTSIM_OK);
    uint64_t last = 0;
    int64_t torn = 0;
    int64_t backwards = 0;
    int64_t lied = 0;
    while (last != POSTS) {
        bool is_new = false;
        const big_value *value = ss_mailbox_take(mailbox, &is_new);
        if (value == NULL) {
            sched_yield();
            continue;
        }
        const uint64_t number = value->word[0];
        for (int w = 1; w < WORDS; ++w) {
            torn += value->word[w] != number;
        }
        backwards += number < last;
        lied += is_new != (number > last);
        last = number;
        if (!is_new) {
            sched_yield();
        }
    }
    ss_thread_join(&writer);
    assert_null(writer);
    assert_int_equal(torn, 0);
    assert_int_equal(backwards, 0);
    assert_int_equal(lied, 0);
    ss_mailbox_destroy(&mailbox);
}

/* ---- ring ---- */

typedef struct record {
    uint64_t number, copy[4];
} record;

static record record_make(uint64_t number)
{
    return (record){number, {number, ~number, number * 3, number ^ 0x5555}};
}

static bool record_is_whole(const record *r)
{
    const record expected = record_make(r->number);
    return memcmp(&expected, r, sizeof expected) == 0;
}

TEST(ring_keeps_order_and_refuses_what_does_not_fit)
{
    ss_ring *ring = ss_ring_create(sizeof(int), 5); /* rounded up to 8 */
    assert_non_null(ring);
    int value = 0;
    assert_false(ss_ring_pop(ring, &value));
    int pushed = 0;
    int popped = 0;
    for (int round = 0; round < 50; ++round) {
        for (int fill = 0; fill < 8; ++fill) {
            assert_true(ss_ring_push(ring, &pushed));
            ++pushed;
        }
        const int extra = -1;
        assert_false(ss_ring_push(ring, &extra));
        const int take = 1 + round % 8;
        for (int i = 0; i < take; ++i) {
            assert_true(ss_ring_pop(ring, &value));
            assert_int_equal(value, popped++);
        }
        while (ss_ring_pop(ring, &value)) {
            assert_int_equal(value, popped++);
        }
    }
    assert_int_equal(popped, pushed);
    assert_int_equal(ss_ring_refused(ring), 50);
    ss_ring_destroy(&ring);
    assert_null(ring);
    assert_null(ss_ring_create(8, 0));
    assert_null(ss_ring_create(8, UINT32_MAX));
}

typedef struct push_job {
    ss_ring *ring;
    uint64_t refused;
} push_job;

static void *push_many(void *argument)
{
    push_job *job = argument;
    for (uint64_t i = 1; i <= POSTS; ++i) {
        const record r = record_make(i);
        while (!ss_ring_push(job->ring, &r)) {
            job->refused += 1;
            sched_yield();
        }
    }
    return NULL;
}

TEST(ring_between_two_threads_loses_and_tears_nothing)
{
    push_job job = {ss_ring_create(sizeof(record), 64), 0};
    ss_thread *writer = NULL;
    assert_int_equal(start(push_many, &job, &writer), SOFTSIM_OK);
    uint64_t expected = 1;
    int64_t wrong = 0;
    while (expected <= POSTS) {
        record r;
        if (!ss_ring_pop(job.ring, &r)) {
            sched_yield();
            continue;
        }
        wrong += r.number != expected || !record_is_whole(&r);
        expected += 1;
    }
    ss_thread_join(&writer);
    record left;
    assert_false(ss_ring_pop(job.ring, &left));
    assert_int_equal(wrong, 0);
    assert_int_equal(ss_ring_refused(job.ring), job.refused);
    ss_ring_destroy(&job.ring);
}

/* ---- histogram ---- */

TEST(histogram_agrees_with_sorting)
{
    enum { SAMPLES = 20000 };
    static ss_histogram histogram;
    static double sample[SAMPLES];
    uint64_t seed = 7;
    ss_histogram_init(&histogram, 0);
    for (int i = 0; i < SAMPLES; ++i) {
        sample[i] = 0.02 * pow(1e7, ss_random_unit(&seed)); /* 0.02 us .. 0.2 s */
        ss_histogram_add(&histogram, (int64_t)i * 400000, sample[i]);
    }
    qsort(sample, SAMPLES, sizeof sample[0], ss_compare_doubles);
    const double quantile[] = {0.001, 0.1, 0.5, 0.9, 0.99, 0.999};
    for (size_t q = 0; q < sizeof quantile / sizeof quantile[0]; ++q) {
        const double exact = sample[(int)ceil(quantile[q] * SAMPLES) - 1];
        const double found = ss_histogram_quantile(&histogram, quantile[q]);
        assert_true(fabs(found - exact) <= 0.0101 * exact);
    }
    assert_true(ss_histogram_quantile(&histogram, 1.0) == sample[SAMPLES - 1]);
}

TEST(histogram_forgets_after_ten_seconds)
{
    static ss_histogram histogram;
    const int64_t second = 1000000000;
    ss_histogram_init(&histogram, 5 * second);
    assert_true(ss_histogram_quantile(&histogram, 0.5) == 0.0);
    ss_histogram_add(&histogram, 5 * second, 1000.0);
    ss_histogram_add(&histogram, 14 * second, 10.0);
    assert_true(ss_histogram_quantile(&histogram, 1.0) == 1000.0);
    ss_histogram_add(&histogram, 15 * second, 10.0);
    assert_true(ss_histogram_quantile(&histogram, 1.0) == 10.0);
    ss_histogram_add(&histogram, 1000 * second, 3.0);
    assert_true(ss_histogram_quantile(&histogram, 1.0) == 3.0);
    assert_true(ss_histogram_quantile(&histogram, 0.0) <= 3.0);
}

TEST(histogram_takes_odd_values)
{
    static ss_histogram histogram;
    ss_histogram_init(&histogram, 0);
    ss_histogram_add(&histogram, 0, -1.0);
    ss_histogram_add(&histogram, 0, (double)NAN);
    ss_histogram_add(&histogram, 0, 0.0);
    assert_true(ss_histogram_quantile(&histogram, 1.0) == 0.0);
    ss_histogram_add(&histogram, 0, 1e12);
    assert_true(ss_histogram_quantile(&histogram, 1.0) == 1e12);
}

/* ---- memory, clock, threads ---- */

TEST(memory_is_aligned_zeroed_and_counted)
{
    const int64_t before = ss_memory_in_use();
    unsigned char *a = ss_memory_get(1001, 3);
    void *b = ss_memory_get(0, 8);
    assert_non_null(a);
    assert_non_null(b);
    assert_int_equal((uintptr_t)a % 64, 0);
    for (int i = 0; i < 3003; ++i) {
        assert_int_equal(a[i], 0);
    }
    assert_int_equal(ss_memory_in_use() - before, 3003);
    assert_null(ss_memory_get(SIZE_MAX / 2, 3));
    assert_null(ss_memory_get(SIZE_MAX, 1));
    SS_EACH(ss_memory_free, a, b, NULL);
    assert_int_equal(ss_memory_in_use(), before);
}

TEST(arena_remembers_what_it_could_not_give_and_frees_all_at_once)
{
    const int64_t before = ss_memory_in_use();
    ss_arena arena = {0};
    assert_int_equal(ss_arena_status(&arena), SOFTSIM_OK);
    for (size_t k = 0; k < 100; ++k) {
        unsigned char *piece = ss_arena_get(&arena, k, 3);
        assert_non_null(piece);
        assert_int_equal((uintptr_t)piece % 64, 0);
        for (size_t b = 0; b < 3 * k; ++b) {
            assert_int_equal(piece[b], 0);
            piece[b] = 0xa5;
        }
    }
    assert_true(ss_memory_in_use() - before >= 3 * 99 * 100 / 2);
    assert_int_equal(ss_arena_status(&arena), SOFTSIM_OK);
    assert_null(ss_arena_get(&arena, SIZE_MAX / 2, 3));
    assert_non_null(ss_arena_get(&arena, 1, 1));
    assert_null(ss_arena_get(&arena, SIZE_MAX, 1));
    assert_int_equal(ss_arena_status(&arena), SOFTSIM_ERROR_MEMORY);
    ss_arena_free(&arena);
    assert_int_equal(ss_memory_in_use(), before);
    assert_int_equal(ss_arena_status(&arena), SOFTSIM_OK);
    ss_arena_free(&arena);
}

TEST(clock_sleeps_until_the_deadline_and_not_before)
{
    const int64_t deadline = ss_clock_now_ns() + 2000000;
    ss_clock_sleep_until(deadline);
    assert_true(ss_clock_now_ns() >= deadline);
    ss_clock_sleep_until(-5); /* long past: returns at once */
    const int64_t cpu = ss_clock_thread_cpu_ns();
    assert_true(cpu > 0 && ss_clock_thread_cpu_ns() >= cpu);
}

typedef struct thread_seen {
    char name[16];
    float smallest;
    int policy;
} thread_seen;

static void *look_around(void *argument)
{
    thread_seen *seen = argument;
    pthread_getname_np(pthread_self(), seen->name, sizeof seen->name);
    volatile float smallest = FLT_MIN;
    smallest = smallest * 0.5f;
    seen->smallest = smallest;
    struct sched_param param;
    pthread_getschedparam(pthread_self(), &seen->policy, &param);
    return NULL;
}

TEST(threads_carry_their_name_and_flush_denormals)
{
    thread_seen seen = {"", 1.0f, -1};
    ss_thread *thread = NULL;
    bool fifo_refused = true;
    assert_int_equal(ss_thread_start("a name that is too long", 50, SS_REALTIME_OFF, look_around,
                                     &seen, &thread, &fifo_refused),
                     SOFTSIM_OK);
    ss_thread_join(&thread);
    assert_null(thread);
    ss_thread_join(&thread);
    assert_string_equal(seen.name, "a name that is ");
    assert_false(fifo_refused);
    assert_int_equal(seen.policy, SCHED_OTHER);
#if defined(__SSE__) || defined(__aarch64__)
    assert_true(seen.smallest == 0.0f);
#endif
}

TEST(fifo_is_had_or_its_refusal_is_said)
{
    thread_seen seen = {"", 1.0f, -1};
    ss_thread *thread = NULL;
    bool fifo_refused = false;
    assert_int_equal(
        ss_thread_start("auto", 10, SS_REALTIME_AUTO, look_around, &seen, &thread, &fifo_refused),
        SOFTSIM_OK);
    ss_thread_join(&thread);
    assert_int_equal(seen.policy, fifo_refused ? SCHED_OTHER : SCHED_FIFO);
    /* A priority that no system grants: automatic falls back, demanded fails. */
    assert_int_equal(
        ss_thread_start("auto", 1000, SS_REALTIME_AUTO, look_around, &seen, &thread, &fifo_refused),
        SOFTSIM_OK);
    ss_thread_join(&thread);
    assert_true(fifo_refused);
    assert_int_equal(seen.policy, SCHED_OTHER);
    assert_int_equal(
        ss_thread_start("fifo", 1000, SS_REALTIME_FIFO, look_around, &seen, &thread, &fifo_refused),
        SOFTSIM_ERROR_SYSTEM);
    assert_null(thread);
}

TEST(wake_is_seen_by_poll_until_drained)
{
    const int fd = ss_wake_open();
    assert_true(fd >= 0);
    struct pollfd waiting = {.fd = fd, .events = POLLIN};
    assert_int_equal(poll(&waiting, 1, 0), 0);
    ss_wake_signal(fd);
    ss_wake_signal(fd);
    assert_int_equal(poll(&waiting, 1, 0), 1);
    ss_wake_drain(fd);
    assert_int_equal(poll(&waiting, 1, 0), 0);
    ss_wake_drain(fd); /* nothing there: does not block */
    close(fd);
}

/* ---- errors ---- */

TEST(status_has_a_name_and_a_text)
{
    assert_string_equal(softsim_status_name(SOFTSIM_OK), "OK");
    assert_string_equal(softsim_status_name(SOFTSIM_ERROR_MESH), "ERROR_MESH");
    assert_string_equal(softsim_status_text(SOFTSIM_ERROR_NETWORK), "no network");
    assert_non_null(softsim_status_name((softsim_status)77));
    assert_non_null(softsim_status_text((softsim_status)77));
}

TEST(verdicts_and_refusals_have_names)
{
    assert_string_equal(softsim_verdict_name(SOFTSIM_VERDICT_GUARDED), "guarded");
    assert_string_equal(softsim_verdict_name((softsim_verdict)4), "unknown");
    assert_string_equal(softsim_refusal_name(SOFTSIM_REFUSED_JUMP), "jump");
    assert_string_equal(softsim_refusal_name(SOFTSIM_REFUSED_OTHER), "other");
    assert_string_equal(softsim_refusal_name(SOFTSIM_REFUSED_COUNT), "unknown");
    assert_string_equal(softsim_refusal_name(SOFTSIM_ACCEPTED), "unknown");
}

TEST(errors_keep_every_line_and_the_first_status)
{
    static softsim_error error;
    memset(&error, 0, sizeof error);
    softsim_error_add(NULL, SOFTSIM_ERROR_MESH, "ignored");
    softsim_error_add(&error, SOFTSIM_ERROR_SCENE, "a.yaml:%d: bad", 3);
    softsim_error_add(&error, SOFTSIM_ERROR_MESH, "b.mesh: worse");
    assert_int_equal(error.status, SOFTSIM_ERROR_SCENE);
    assert_int_equal(error.fault_count, 2);
    assert_string_equal(error.text, "a.yaml:3: bad\nb.mesh: worse");
}

/* A terminal obeys control characters: ESC, CSI in one byte and in UTF-8, what turns text around.
 */
TEST(nothing_that_is_shown_drives_a_terminal)
{
    static const says_row cases[] = {
        {"", ""},
        {"Niere, 5 mm", "Niere, 5 mm"},
        {"a\tb", "a b"},
        {"Milz\xc3\xa4 \xe2\x82\xac \xf0\x9f\x90\x8d \xc2\xa0",
         "Milz\xc3\xa4 \xe2\x82\xac \xf0\x9f\x90\x8d \xc2\xa0"},
        {"\x1b[31m\x07\x7f\r", "?[31m???"},
        {"a\nforged", "a?forged"},
        {"\x9b"
         "31m\x80\x9f",
         "?31m??"},
        {"\xc2\x9b"
         "31m\xc2\x80\xc2\x9f",
         "??31m????"},
        {"\xe0\x82\x9b\xf0\x80\x82\x9b\xc0\x9b", "?????????"}, /* overlong CSI and ESC */
        {"\xe2\x80\xa8\xe2\x80\xae\xe2\x81\xa6", "?????????"},
        {"\xc3", "?"},
        {"\xe2\x82", "??"},
        {"\xe9t\xe9", "?t?"},
        {"\xed\xa0\x80\xf4\x90\x80\x80\xff\xfe", "?????????"},
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        char text[64];
        snprintf(text, sizeof text, "%s", cases[c].given);
        ss_plain_clean(text);
        assert_string_equal(text, cases[c].says);
        static softsim_error error;
        memset(&error, 0, sizeof error);
        softsim_error_add(&error, SOFTSIM_ERROR_FILE, "<%s>", cases[c].given);
        assert_int_equal(strncmp(error.text + 1, cases[c].says, strlen(cases[c].says)), 0);
        assert_int_equal(strlen(error.text), strlen(cases[c].says) + 2);
        char *printed = NULL;
        size_t size = 0;
        FILE *out = open_memstream(&printed, &size);
        ss_plain_print(out, "<%s>\n", cases[c].given);
        assert_int_equal(fclose(out), 0);
        assert_int_equal(size, strlen(cases[c].says) + 3);
        assert_int_equal(strncmp(printed + 1, cases[c].says, size - 3), 0);
        assert_string_equal(printed + size - 2, ">\n");
        free(printed);
    }
    /* Every byte by itself, and every pair. */
    for (int first = 1; first < 256; ++first) {
        for (int second = 1; second < 256; ++second) {
            char text[3] = {(char)first, (char)second, '\0'};
            ss_plain_clean(text);
            const unsigned char a = (unsigned char)text[0], b = (unsigned char)text[1];
            const bool is_pair = a >= 0xc2 && a < 0xe0 && b >= 0x80 && b < 0xc0;
            assert_true(is_pair ? a > 0xc2 || b >= 0xa0
                                : a >= ' ' && a < 0x7f && b >= ' ' && b < 0x7f);
        }
    }
    /* Text that was put together in lines keeps them. */
    static softsim_error error;
    softsim_error_append(&error, SOFTSIM_ERROR_FILE, "s.yaml:1: bad\nmesh: \x9b\n      ^");
    assert_string_equal(error.text, "s.yaml:1: bad\nmesh: ?\n      ^");
}

TEST(a_full_error_says_how_many_more)
{
    static softsim_error error;
    for (int length = 1; length < 400; length += FULL_IN_RELEASE(7, 57)) {
        memset(&error, 0, sizeof error);
        enum { FAULTS = 9000 };
        for (int i = 0; i < FAULTS; ++i) {
            softsim_error_add(&error, SOFTSIM_ERROR_SCENE, "%0*d", length, 7);
        }
        assert_int_equal(error.fault_count, FAULTS);
        /* Lines shown and lines said to be hidden make all. */
        int shown = 0;
        const char *line = error.text;
        for (const char *end = strchr(line, '\n'); end != NULL; end = strchr(line, '\n')) {
            assert_int_equal(end - line, length);
            shown += 1;
            line = end + 1;
        }
        int hidden = 0;
        assert_int_equal(sscanf(line, "(and %d more faults)", &hidden), 1);
        assert_int_equal(shown + hidden, FAULTS);
        assert_true(strlen(error.text) > SOFTSIM_ERROR_TEXT_SIZE - 64 - (size_t)length);
    }
}

TEST(an_endless_first_fault_is_cut)
{
    static softsim_error error;
    memset(&error, 0, sizeof error);
    softsim_error_add(&error, SOFTSIM_ERROR_FILE, "%020000d", 1);
    assert_true(strlen(error.text) > 8000);
    softsim_error_add(&error, SOFTSIM_ERROR_FILE, "second");
    softsim_error_add(&error, SOFTSIM_ERROR_FILE, "third");
    assert_non_null(strstr(error.text, "\n(and 2 more faults)"));
}

/* ---- files ---- */

/* Digits alone name an open file: what else strtol would take is the name of another. */
TEST(only_digits_name_a_descriptor)
{
    static const struct {
        const char *path;
        int number;
    } cases[] = {{"/dev/stdout", 1},       {"/dev/stderr", 2},
                 {"/dev/fd/7", 7},         {"/proc/self/fd/12", 12},
                 {"/dev/fd/", -1},         {"/dev/fd/+1", -1},
                 {"/dev/fd/-1", -1},       {"/dev/fd/ 1", -1},
                 {"/dev/fd/1x", -1},       {"/dev/fd/1/", -1},
                 {"/proc/self/fd/+2", -1}, {"/dev/fd/99999", -1},
                 {"dev/fd/1", -1},         {"", -1}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        assert_int_equal(ss_files_descriptor(cases[k].path), cases[k].number);
    }
}

/* ---- progress ---- */

/* A terminal whose other side nobody reads: what is written to it never gets through. */
TEST(a_stalled_reader_holds_up_no_work)
{
    char name[64], text[512];
    const int keyboard = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    assert_true(keyboard >= 0);
    assert_int_equal(grantpt(keyboard), 0);
    assert_int_equal(unlockpt(keyboard), 0);
    assert_int_equal(ptsname_r(keyboard, name, sizeof name), 0);
    const int screen = open(name, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    assert_true(screen >= 0);
    memset(text, 'x', sizeof text);
    while (write(screen, text, sizeof text) > 0) {
    }
    assert_int_equal(fcntl(screen, F_SETFL, 0), 0);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        alarm(600); /* against hanging alone */
        if (dup2(screen, STDERR_FILENO) >= 0 && isatty(STDERR_FILENO) == 1) {
            ss_progress_begin("knead", "work");
            ss_progress_stage("that goes on");
            ss_progress_end();
            _exit(0);
        }
        _exit(1);
    }
    int status = -1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    close(screen);
    close(keyboard);
}

/* On a terminal at once, one line that is wiped in the end; elsewhere short work says nothing. */
TEST(progress_is_shown_and_wiped)
{
    char out[1024];
    size_t used = 0;
    ssize_t more = 1;
    const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    assert_true(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0);
    const int end = open(ptsname(terminal), O_RDWR | O_NOCTTY | O_CLOEXEC);
    const int kept = dup(STDERR_FILENO);
    assert_true(end >= 0 && kept >= 0 && dup2(end, STDERR_FILENO) >= 0);
    ss_progress_stage("nobody has begun");
    ss_progress_begin("knead", "reading %d files", 3);
    ss_progress_end();
    ss_progress_end();
    fflush(stderr);
    assert_true(dup2(kept, STDERR_FILENO) >= 0);
    close(end);
    while (more > 0 && used + 1 < sizeof out) { /* an error once all is read */
        more = read(terminal, out + used, sizeof out - 1 - used);
        used += more > 0 ? (size_t)more : 0;
    }
    out[used] = '\0';
    close(terminal);
    assert_string_equal(out, "\rknead: reading 3 files, 0 s \033[K\r\033[K");

    int pipe_fd[2];
    assert_int_equal(pipe(pipe_fd), 0);
    assert_true(dup2(pipe_fd[1], STDERR_FILENO) >= 0);
    ss_progress_begin("knead", "short work");
    ss_progress_stage("and its end");
    ss_progress_end();
    fflush(stderr);
    assert_true(dup2(kept, STDERR_FILENO) >= 0);
    close(pipe_fd[1]);
    assert_int_equal(read(pipe_fd[0], out, sizeof out), 0);
    close(pipe_fd[0]);
    close(kept);
}

/* The first numbers for the seed 1234567, as Rosetta Code publishes them. */
TEST(random_numbers_are_those_of_splitmix64)
{
    static const uint64_t wanted[] = {UINT64_C(6457827717110365317), UINT64_C(3203168211198807973),
                                      UINT64_C(9817491932198370423)};
    uint64_t seed = 1234567;
    for (int i = 0; i < 3; ++i) {
        assert_true(ss_random_next(&seed) == wanted[i]);
    }
    uint64_t zero = 0;
    for (uint64_t i = 0; i < 1000; ++i) {
        const double drawn = ss_random_signed(&zero);
        assert_true(drawn >= -1.0 && drawn < 1.0);
        assert_true(ss_random_signed_at(i) == drawn);
        assert_true(ss_random_below(&seed, 3) < 3);
    }
}

TEST(texts_become_strings_of_json)
{
    static const says_row cases[] = {
        {"", "\"\""},
        {"a \"b\" \\ c", "\"a \\\"b\\\" \\\\ c\""},
        {"\n\x1b\x7f", "\"\\u000a\\u001b\\u007f\""},
        {"\xc3\xa4\xe2\x82\xac", "\"\\u00e4\\u20ac\""}, /* U+E4 U+20AC */
        {"\xf0\x9f\x98\x80", "\"\\ud83d\\ude00\""},     /* U+1F600 */
        {"\xff\xc3", "\"\\u00ff\\u00c3\""}};            /* no UTF-8 */
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        char *out = NULL;
        size_t size = 0;
        FILE *file = open_memstream(&out, &size);
        ss_plain_json(file, cases[c].given);
        assert_int_equal(fclose(file), 0);
        assert_string_equal(out, cases[c].says);
        free(out);
    }
}

TEST(a_reason_is_an_error_without_its_place)
{
    static const char *const cases[][2] = {{"/tmp/a.yaml:3:4: error: no: none", "error: no: none"},
                                           {"out of memory\nb: c", "out of memory"},
                                           {"a.yaml: first\nb.yaml: second", "first"},
                                           {"", ""}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        char out[32];
        ss_plain_reason("", cases[c][0], out, sizeof out);
        assert_string_equal(out, cases[c][1]);
        ss_plain_reason("", cases[c][0], out, 4);
        assert_true(strlen(out) <= 3 && strncmp(out, cases[c][1], strlen(out)) == 0);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
