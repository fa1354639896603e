/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "recorder.h"

#include <inttypes.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "process.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/thread.h"
#include "softsim/log.h"

enum {
    NAME_SIZE = 64,
    MAX_TRIES = 1000, /* names of one second that others have taken */
    PERIOD_MS = 20,   /* of looking into the ring */
    OVERHEAD = 28     /* bytes of a record beside its channel and data */
};

/* In front of each message in the ring; its channel, with the NUL, and its data follow. */
typedef struct record_head {
    int64_t utime_us;
    int32_t channel_size, size;
} record_head;

typedef struct recording {
    char name[NAME_SIZE];
    char *path;
    bool is_finished;
} recording;

struct ss_recorder {
    ss_recorder_config config;
    pthread_t thread;
    bool has_thread;
    int wake; /* ends the thread's wait */
    atomic_bool is_wanted, is_ending;

    /* The ring: bytes tail .. head - 1, by their remainder. `head` is released by who takes, and
     * acquired by the thread; `tail` the other way. */
    uint8_t *ring;
    _Atomic uint64_t head, tail;
    atomic_bool is_taking;
    _Atomic uint64_t lost;       /* of this recording */
    atomic_bool has_two_servers; /* likewise */

    /* recorder's thread */
    softsim_log_writer *log;
    int64_t recorded, in_all; /* bytes */
    int32_t number;           /* in the name of the last one */
    bool is_full;             /* all together are as large as they may be */
    uint64_t told_lost;
    softsim_error unfinished; /* one fault a recording; read at the close */
    uint8_t data[SOFTSIM_LOG_MAX_DATA];

    pthread_mutex_t lock; /* of all below; never held while a file is touched */
    recording *recordings;
    int32_t count;
    bool is_recording;
    char fault[512];
    _Atomic uint64_t version;
};

/* ---- the ring ---- */

static void put(ss_recorder *recorder, uint64_t at, const void *data, size_t size)
{
    const uint64_t room = recorder->config.ring_bytes, begin = at & (room - 1);
    const size_t first = size < room - begin ? size : (size_t)(room - begin);
    memcpy(recorder->ring + begin, data, first);
    memcpy(recorder->ring, (const uint8_t *)data + first, size - first);
}

static void get(const ss_recorder *recorder, uint64_t at, void *out, size_t size)
{
    const uint64_t room = recorder->config.ring_bytes, begin = at & (room - 1);
    const size_t first = size < room - begin ? size : (size_t)(room - begin);
    memcpy(out, recorder->ring + begin, first);
    memcpy((uint8_t *)out + first, recorder->ring, size - first);
}

void ss_recorder_take(ss_recorder *recorder, int64_t utime_us, const char *channel,
                      const void *data, int32_t size)
{
    if (!atomic_load_explicit(&recorder->is_taking, memory_order_acquire)) {
        return;
    }
    const record_head head = {
        .utime_us = utime_us, .channel_size = (int32_t)strlen(channel) + 1, .size = size};
    const uint64_t need = sizeof head + (uint64_t)head.channel_size + (uint64_t)size;
    const uint64_t at = atomic_load_explicit(&recorder->head, memory_order_relaxed);
    const uint64_t tail = atomic_load_explicit(&recorder->tail, memory_order_acquire);
    if (head.channel_size > SOFTSIM_LOG_CHANNEL_SIZE || size > SOFTSIM_LOG_MAX_DATA ||
        need > recorder->config.ring_bytes - (at - tail)) {
        atomic_fetch_add_explicit(&recorder->lost, 1, memory_order_relaxed);
        return;
    }
    put(recorder, at, &head, sizeof head);
    put(recorder, at + sizeof head, channel, (size_t)head.channel_size);
    put(recorder, at + sizeof head + (uint64_t)head.channel_size, data, (size_t)size);
    atomic_store_explicit(&recorder->head, at + need, memory_order_release);
}

void ss_recorder_mark_servers(ss_recorder *recorder)
{
    atomic_store(&recorder->has_two_servers, true);
}

/* ---- report ---- */

static void tell(ss_recorder *recorder, bool is_recording, const char *fault)
{
    pthread_mutex_lock(&recorder->lock);
    recorder->is_recording = is_recording;
    snprintf(recorder->fault, sizeof recorder->fault, "%s", fault);
    pthread_mutex_unlock(&recorder->lock);
    atomic_fetch_add(&recorder->version, 1);
}

uint64_t ss_recorder_version(const ss_recorder *recorder)
{
    return atomic_load(&recorder->version);
}

void ss_recorder_tell(ss_recorder *recorder, FILE *out)
{
    pthread_mutex_lock(&recorder->lock);
    fprintf(out, "{\"type\": \"recording\", \"is_recording\": %s, \"fault\": ",
            recorder->is_recording ? "true" : "false");
    ss_plain_json(out, recorder->fault);
    fputs(", \"files\": [", out);
    const char *comma = "";
    for (int32_t i = 0; i < recorder->count; ++i) {
        if (recorder->recordings[i].is_finished) {
            fprintf(out, "%s\"%s\"", comma, recorder->recordings[i].name);
            comma = ", ";
        }
    }
    fprintf(out, "], \"lost\": %" PRIu64 ", \"is_temporary\": %s}", atomic_load(&recorder->lost),
            recorder->config.is_temporary ? "true" : "false");
    pthread_mutex_unlock(&recorder->lock);
}

const char *ss_recorder_path(ss_recorder *recorder, const char *name)
{
    const char *path = NULL;
    pthread_mutex_lock(&recorder->lock);
    for (int32_t i = 0; i < recorder->count; ++i) {
        const recording *known = &recorder->recordings[i];
        if (known->is_finished && strcmp(known->name, name) == 0) {
            path = known->path;
        }
    }
    pthread_mutex_unlock(&recorder->lock);
    return path;
}

/* ---- recording: the recorder's thread ---- */

static double gigabytes(int64_t bytes)
{
    return 1e-9 * (double)bytes;
}

/* Writes out what is left, and what `why` it ended ("": as it should). */
static void end_recording(ss_recorder *recorder, const char *why)
{
    char fault[sizeof recorder->fault];
    softsim_error error = {.status = SOFTSIM_OK};
    const uint64_t lost = atomic_load(&recorder->lost);
    const bool is_good = softsim_log_finish(&recorder->log, &error) == SOFTSIM_OK;
    if (!is_good) {
        softsim_error_append(&recorder->unfinished, error.status, error.text);
    }
    int length = snprintf(fault, sizeof fault, "%.360s", is_good ? why : error.text);
    if (lost > 0) {
        length += snprintf(fault + length, sizeof fault - (size_t)length,
                           "%s%" PRIu64 " messages are missing in it: the disk was too slow",
                           length > 0 ? "; " : "", lost);
    }
    if (atomic_load(&recorder->has_two_servers)) {
        snprintf(fault + length, sizeof fault - (size_t)length,
                 "%smore than one server answered in it", length > 0 ? "; " : "");
    }
    pthread_mutex_lock(&recorder->lock);
    recorder->recordings[recorder->count - 1].is_finished = is_good;
    pthread_mutex_unlock(&recorder->lock);
    tell(recorder, false, fault);
}

static void stop_taking(ss_recorder *recorder)
{
    atomic_store(&recorder->is_taking, false);
    atomic_store(&recorder->is_wanted, false);
}

/* One message more; false when it was the limit, or the disk, that ended the recording. */
static bool write_one(ss_recorder *recorder, const record_head *head, const char *channel)
{
    char why[256] = "";
    const ss_recorder_config *config = &recorder->config;
    const int64_t need = OVERHEAD + (int64_t)head->channel_size - 1 + head->size;
    if (recorder->in_all + need > config->most_in_all) {
        recorder->is_full = true;
        snprintf(why, sizeof why,
                 "it ended at %.3g GB: with it the recordings of this run are as large as they "
                 "may be, %.3g GB in all",
                 gigabytes(recorder->recorded), gigabytes(config->most_in_all));
    } else if (recorder->recorded + need > config->most_bytes) {
        snprintf(why, sizeof why, "it ended at %.3g GB, the most that one recording may have",
                 gigabytes(recorder->recorded));
    } else {
        softsim_log_write(recorder->log, head->utime_us, channel, recorder->data, head->size);
        recorder->recorded += need;
        recorder->in_all += need;
    }
    if (why[0] == '\0' && !softsim_log_has_failed(recorder->log)) {
        return true;
    }
    stop_taking(recorder);
    end_recording(recorder, why);
    return false;
}

/* Writes what is in the ring by now. */
static void drain(ss_recorder *recorder)
{
    const uint64_t end = atomic_load_explicit(&recorder->head, memory_order_acquire);
    uint64_t at = atomic_load_explicit(&recorder->tail, memory_order_relaxed);
    while (recorder->log != NULL && at < end) {
        record_head head;
        char channel[SOFTSIM_LOG_CHANNEL_SIZE];
        get(recorder, at, &head, sizeof head);
        at += sizeof head;
        get(recorder, at, channel, (size_t)head.channel_size);
        at += (uint64_t)head.channel_size;
        get(recorder, at, recorder->data, (size_t)head.size);
        at += (uint64_t)head.size;
        atomic_store_explicit(&recorder->tail, at, memory_order_release);
        (void)write_one(recorder, &head, channel);
    }
}

/* Is there a place for one more? If not, `fault` says why. */
static bool has_place(const ss_recorder *recorder, char *fault, size_t size)
{
    const ss_recorder_config *config = &recorder->config;
    if (recorder->is_full) {
        snprintf(fault, size,
                 "the recordings of this run are as large as they may be, %.3g GB in all: fetch "
                 "what you need and restart softsim-web",
                 gigabytes(config->most_in_all));
    } else if (recorder->count == config->most_files) {
        snprintf(fault, size, "%d recordings are enough for one run: restart softsim-web",
                 config->most_files);
    }
    return fault[0] == '\0';
}

/* Opens the log of the next recording under the next name that is free: the stamp is also that of
 * who records to the same folder in this second, or did before the clock was set back. */
static bool open_next(ss_recorder *recorder, char *fault, size_t size)
{
    recording *next = &recorder->recordings[recorder->count];
    softsim_error error = {.status = SOFTSIM_OK};
    const time_t now = time(NULL);
    struct tm parts;
    char stamp[32] = "";
    gmtime_r(&now, &parts);
    strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &parts);
    for (int32_t number = recorder->number + 1; number <= recorder->number + MAX_TRIES; ++number) {
        snprintf(next->name, sizeof next->name, "softsim-%s-%d.lcmlog", stamp, number);
        if (asprintf(&next->path, "%s/%s", recorder->config.folder, next->name) < 0) {
            snprintf(fault, size, "out of memory");
            return false;
        }
        if (softsim_log_create_new(next->path, &recorder->log, &error) != SOFTSIM_OK) {
            snprintf(fault, size, "%.400s", error.text);
        }
        if (recorder->log != NULL) {
            recorder->number = number;
            return true;
        }
        free(next->path);
        if (error.fault_count > 0) {
            return false;
        }
    }
    snprintf(fault, size, "%s: a thousand names like %s are taken: move those files away",
             recorder->config.folder, next->name);
    return false;
}

static void begin_recording(ss_recorder *recorder)
{
    char fault[sizeof recorder->fault] = "";
    if (!has_place(recorder, fault, sizeof fault) || !open_next(recorder, fault, sizeof fault)) {
        stop_taking(recorder);
        tell(recorder, false, fault);
        return;
    }
    recorder->recorded = 0;
    recorder->told_lost = 0;
    pthread_mutex_lock(&recorder->lock);
    ++recorder->count;
    pthread_mutex_unlock(&recorder->lock);
    /* What came after the end of the one before is of none. */
    atomic_store(&recorder->tail, atomic_load(&recorder->head));
    atomic_store(&recorder->lost, 0);
    atomic_store(&recorder->has_two_servers, false);
    atomic_store(&recorder->is_taking, true);
    tell(recorder, true, "");
}

static void tell_losses(ss_recorder *recorder)
{
    const uint64_t lost = atomic_load(&recorder->lost);
    if (lost != recorder->told_lost) {
        recorder->told_lost = lost;
        atomic_fetch_add(&recorder->version, 1);
    }
}

static void *run(void *argument)
{
    ss_recorder *recorder = argument;
    for (;;) {
        const bool is_ending = atomic_load(&recorder->is_ending);
        const bool is_wanted = !is_ending && atomic_load(&recorder->is_wanted);
        if (is_wanted && recorder->log == NULL) {
            begin_recording(recorder);
        } else if (!is_wanted && recorder->log != NULL) {
            atomic_store(&recorder->is_taking, false);
            drain(recorder);
            if (recorder->log != NULL) {
                end_recording(recorder, "");
            }
        } else if (recorder->log != NULL) {
            drain(recorder);
            tell_losses(recorder);
        }
        if (is_ending) {
            return NULL;
        }
        struct pollfd wake = {.fd = recorder->wake, .events = POLLIN};
        if (poll(&wake, 1, recorder->log != NULL ? PERIOD_MS : -1) > 0) {
            ss_wake_drain(recorder->wake);
        }
    }
}

void ss_recorder_want(ss_recorder *recorder, bool is_wanted)
{
    atomic_store(&recorder->is_wanted, is_wanted);
    ss_wake_signal(recorder->wake);
}

/* ---- opening ---- */

void ss_recorder_close(ss_recorder **recorder, softsim_error *error)
{
    ss_recorder *r = *recorder;
    if (r == NULL) {
        return;
    }
    if (r->has_thread) {
        atomic_store(&r->is_ending, true);
        ss_wake_signal(r->wake);
        pthread_join(r->thread, NULL);
    }
    if (r->unfinished.fault_count > 0) {
        softsim_error_append(error, r->unfinished.status, r->unfinished.text);
    }
    for (int32_t i = 0; i < r->count; ++i) {
        if (r->config.is_temporary && r->recordings[i].is_finished) {
            remove(r->recordings[i].path);
        }
        free(r->recordings[i].path);
    }
    if (r->wake >= 0) {
        close(r->wake);
    }
    pthread_mutex_destroy(&r->lock);
    free(r->ring);
    free(r->recordings);
    free(r);
    *recorder = NULL;
}

softsim_status ss_recorder_open(const ss_recorder_config *config, ss_recorder **out_recorder,
                                softsim_error *error)
{
    ss_recorder *recorder = calloc(1, sizeof *recorder);
    *out_recorder = recorder;
    if (recorder == NULL) {
        return ss_memory_fault(error);
    }
    recorder->config = *config;
    atomic_store(&recorder->version, 1);
    ss_process_init_lock(&recorder->lock);
    recorder->wake = ss_wake_open();
    recorder->ring = malloc(config->ring_bytes);
    recorder->recordings = calloc((size_t)config->most_files, sizeof recorder->recordings[0]);
    softsim_status status = SOFTSIM_OK;
    if (recorder->ring == NULL || recorder->recordings == NULL) {
        status = ss_memory_fault(error);
    } else if (recorder->wake < 0 || pthread_create(&recorder->thread, NULL, run, recorder) != 0) {
        status = SOFTSIM_ERROR_SYSTEM;
        softsim_error_add(error, status,
                          "cannot start a thread; raise `ulimit -u` and `ulimit -n`");
    }
    recorder->has_thread = status == SOFTSIM_OK;
    if (status != SOFTSIM_OK) {
        ss_recorder_close(out_recorder, error);
    }
    return status;
}
