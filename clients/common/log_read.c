/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Reader of LCM event logs. A record, all numbers big-endian:
 *
 *   0 magic 0xEDA1DA01   4 event number (8)   12 utime (8)   20 channel length   24 data length
 *   28 channel (no NUL)  28 + channel length: data
 *
 * Payloads carry no checksum, so damage shows only in the framing: a record is believed when its
 * header is plausible, it ends within the file, and the next record's magic follows. Where no
 * magic follows, either this record's length or the bytes behind it are damaged: a plausible
 * header *inside* its body says the former, and the record is dropped up to there; otherwise it
 * is kept. After damage the reader searches the next plausible header. Every byte is searched at
 * most once, and one window of fixed size is all the memory, whatever the file claims.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "net/codec.h"
#include "rt/files.h"
#include "softsim/log.h"

enum {
    HEADER_SIZE = 28,
    WINDOW_SIZE = 256 * 1024, /* holds header, channel and the longest payload that is kept */
    MAX_CHANNEL = SOFTSIM_LOG_CHANNEL_SIZE - 1
};
_Static_assert(WINDOW_SIZE >= HEADER_SIZE + MAX_CHANNEL + SOFTSIM_LOG_MAX_DATA, "window");

static const uint8_t magic[4] = {0xED, 0xA1, 0xDA, 0x01};

struct softsim_log {
    int fd;
    bool is_unreadable;
    int64_t size; /* of the file, at opening */
    int64_t next; /* where the next record should start */
    int64_t window_start;
    int32_t window_fill;
    uint8_t window[WINDOW_SIZE];
};

typedef enum header_kind {
    HEADER_GOOD,
    HEADER_BAD,   /* no magic, or lengths that no record has */
    HEADER_BEYOND /* cut, or ends behind the end of the file */
} header_kind;

typedef struct header {
    int64_t number, utime_us, end;
    int32_t channel_size, data_size;
} header;

static uint64_t read_big(const uint8_t *bytes, int count)
{
    uint64_t value = 0;
    for (int i = 0; i < count; ++i) {
        value = value << 8 | bytes[i];
    }
    return value;
}

/* `count` (at most WINDOW_SIZE) bytes of the file from `offset`; NULL when they cannot be read. */
static const uint8_t *view(softsim_log *log, int64_t offset, int32_t count)
{
    if (offset < log->window_start || offset + count > log->window_start + log->window_fill) {
        const int64_t rest = log->size - offset;
        const int32_t wanted = rest < WINDOW_SIZE ? (int32_t)rest : WINDOW_SIZE;
        log->window_start = offset;
        log->window_fill = 0;
        while (log->window_fill < wanted) {
            const ssize_t got =
                pread(log->fd, log->window + log->window_fill, (size_t)(wanted - log->window_fill),
                      (off_t)(offset + log->window_fill));
            if (got > 0) {
                log->window_fill += (int32_t)got;
            } else if (got == 0 || errno != EINTR) {
                break;
            }
        }
        if (log->window_fill < count) {
            log->is_unreadable = true; /* also when the file has shrunk meanwhile */
            return NULL;
        }
    }
    return log->window + (offset - log->window_start);
}

static header_kind parse_header(softsim_log *log, int64_t offset, header *out)
{
    const int64_t rest = log->size - offset;
    const int32_t here = rest < HEADER_SIZE ? (int32_t)rest : HEADER_SIZE;
    const uint8_t *bytes = view(log, offset, here);
    if (bytes == NULL || memcmp(bytes, magic, here < 4 ? (size_t)here : 4) != 0) {
        return HEADER_BAD;
    }
    if (here < HEADER_SIZE) {
        return HEADER_BEYOND;
    }
    out->number = (int64_t)read_big(bytes + 4, 8);
    out->utime_us = (int64_t)read_big(bytes + 12, 8);
    const uint64_t channel_size = read_big(bytes + 20, 4);
    const uint64_t data_size = read_big(bytes + 24, 4);
    if (channel_size < 1 || channel_size > MAX_CHANNEL || data_size > INT32_MAX) {
        return HEADER_BAD;
    }
    out->channel_size = (int32_t)channel_size;
    out->data_size = (int32_t)data_size;
    out->end = offset + HEADER_SIZE + out->channel_size + out->data_size;
    if (out->end > log->size) {
        return HEADER_BEYOND;
    }
    const uint8_t *channel = view(log, offset, HEADER_SIZE + out->channel_size);
    for (int32_t i = 0; channel != NULL && i < out->channel_size; ++i) {
        if (channel[HEADER_SIZE + i] <= ' ' || channel[HEADER_SIZE + i] == 0x7F) {
            return HEADER_BAD;
        }
    }
    return channel != NULL ? HEADER_GOOD : HEADER_BAD;
}

/* The first plausible header that starts in [from, to); -1 when there is none. */
static int64_t find_header(softsim_log *log, int64_t from, int64_t to)
{
    while (from < to) {
        const int64_t rest = to - from;
        const int32_t block = rest < WINDOW_SIZE / 2 ? (int32_t)rest : WINDOW_SIZE / 2;
        const uint8_t *bytes = view(log, from, block);
        if (bytes == NULL) {
            return -1;
        }
        const uint8_t *hit = memchr(bytes, magic[0], (size_t)block);
        if (hit == NULL) {
            from += block;
            continue;
        }
        from += hit - bytes;
        header ignored;
        if (parse_header(log, from, &ignored) == HEADER_GOOD) {
            return from;
        }
        ++from;
    }
    return -1;
}

/* Does a record, or the end, follow at `offset`? A magic cut by the end of the file counts. Read
 * past the window, so that a far `offset` does not throw the window away. */
static bool is_followed(softsim_log *log, int64_t offset)
{
    const int64_t rest = log->size - offset;
    const int32_t count = rest < 4 ? (int32_t)rest : 4;
    if (count == 0) {
        return true;
    }
    uint8_t bytes[4];
    if (offset >= log->window_start && offset + count <= log->window_start + log->window_fill) {
        memcpy(bytes, log->window + (offset - log->window_start), (size_t)count);
    } else if (pread(log->fd, bytes, (size_t)count, (off_t)offset) != count) {
        return false;
    }
    return memcmp(bytes, magic, (size_t)count) == 0;
}

softsim_status softsim_log_open(const char *path, softsim_log **out_log, softsim_error *error)
{
    *out_log = NULL;
    int64_t size = 0;
    const char *why = NULL;
    const int fd = ss_files_open(path, &size, &why);
    if (fd < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: %s", path, why);
        return SOFTSIM_ERROR_FILE;
    }
    softsim_log *log = malloc(sizeof *log);
    if (log == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
        close(fd);
        return SOFTSIM_ERROR_MEMORY;
    }
    log->fd = fd;
    log->is_unreadable = false;
    log->size = size;
    log->next = 0;
    log->window_start = 0;
    log->window_fill = 0;
    *out_log = log;
    return SOFTSIM_OK;
}

void softsim_log_close(softsim_log **log)
{
    if (*log != NULL) {
        close((*log)->fd);
        free(*log);
        *log = NULL;
    }
}

void softsim_log_rewind(softsim_log *log)
{
    log->next = 0;
}

/* Reports the bytes from the present place to `to` as lost and goes on there. */
static softsim_log_result skip(softsim_log *log, int64_t to, softsim_log_result result,
                               softsim_log_event *out)
{
    *out = (softsim_log_event){.offset = log->next, .skipped = to - log->next};
    log->next = to;
    return result;
}

softsim_log_result softsim_log_next(softsim_log *log, softsim_log_event *out_event)
{
    *out_event = (softsim_log_event){.offset = log->next};
    if (log->next >= log->size) {
        return SOFTSIM_LOG_END;
    }
    header head = {0};
    const header_kind kind = parse_header(log, log->next, &head);
    int64_t resume = -1;
    if (kind != HEADER_GOOD) {
        resume = find_header(log, log->next + 1, log->size);
    } else if (!is_followed(log, head.end)) {
        resume = find_header(log, log->next + 1, head.end);
    }
    if (!log->is_unreadable && resume >= 0) {
        return skip(log, resume, SOFTSIM_LOG_DAMAGED, out_event);
    }
    if (!log->is_unreadable && kind != HEADER_GOOD) {
        return skip(log, log->size,
                    kind == HEADER_BEYOND ? SOFTSIM_LOG_TRUNCATED : SOFTSIM_LOG_DAMAGED, out_event);
    }
    const int32_t fixed = HEADER_SIZE + head.channel_size;
    const bool is_kept = head.data_size <= SOFTSIM_LOG_MAX_DATA;
    const uint8_t *record =
        log->is_unreadable ? NULL : view(log, log->next, is_kept ? fixed + head.data_size : fixed);
    if (record == NULL) {
        log->next = log->size;
        return SOFTSIM_LOG_UNREADABLE;
    }
    out_event->number = head.number;
    out_event->utime_us = head.utime_us;
    memcpy(out_event->channel, record + HEADER_SIZE, (size_t)head.channel_size);
    out_event->data_size = head.data_size;
    out_event->data = is_kept ? record + fixed : NULL;
    log->next = head.end;
    return SOFTSIM_LOG_EVENT;
}

int32_t softsim_log_probe(const char *channel)
{
    static const char tag[] = "_PROBE_";
    const size_t length = strlen(channel);
    const size_t tag_length = sizeof tag - 1;
    if (length < tag_length + 2 ||
        memcmp(channel + length - tag_length - 1, tag, tag_length) != 0) {
        return -1;
    }
    const char digit = channel[length - 1];
    return digit >= '0' && digit < '0' + SOFTSIM_MAX_PROBES ? digit - '0' : -1;
}

bool softsim_log_decode_pose(const void *data, int32_t size, softsim_pose *out_pose)
{
    return ss_wire_decode_pose(data, size, out_pose);
}

bool softsim_log_decode_force(const void *data, int32_t size, softsim_force *out_force)
{
    return ss_wire_decode_force(data, size, out_force);
}
