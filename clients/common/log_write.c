/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Writer of LCM event logs; log_read.c has the record's layout. */
#include <stdlib.h>
#include <string.h>

#include "net/codec.h"
#include "output.h"
#include "softsim/log.h"

struct softsim_log_writer {
    ss_output output;
    int64_t number; /* of the next record */
};

static softsim_status create(const char *path, bool is_new, softsim_log_writer **out_writer,
                             softsim_error *error)
{
    *out_writer = NULL;
    softsim_log_writer *writer = calloc(1, sizeof *writer);
    if (writer == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
        return SOFTSIM_ERROR_MEMORY;
    }
    const softsim_status status =
        (is_new ? ss_output_record_new : ss_output_record)(&writer->output, path, error);
    if (status != SOFTSIM_OK || writer->output.file == NULL) {
        free(writer);
        return status;
    }
    *out_writer = writer;
    return SOFTSIM_OK;
}

softsim_status softsim_log_create(const char *path, softsim_log_writer **out_writer,
                                  softsim_error *error)
{
    return create(path, false, out_writer, error);
}

softsim_status softsim_log_create_new(const char *path, softsim_log_writer **out_writer,
                                      softsim_error *error)
{
    return create(path, true, out_writer, error);
}

static uint8_t *put_big(uint8_t *at, uint64_t value, int count)
{
    for (int i = 0; i < count; ++i) {
        at[i] = (uint8_t)(value >> (8 * (count - 1 - i)));
    }
    return at + count;
}

void softsim_log_write(softsim_log_writer *writer, int64_t utime_us, const char *channel,
                       const void *data, int32_t size)
{
    uint8_t head[28];
    const size_t channel_size = strnlen(channel, SOFTSIM_LOG_CHANNEL_SIZE - 1);
    uint8_t *at = put_big(head, 0xEDA1DA01u, 4);
    at = put_big(at, (uint64_t)writer->number++, 8);
    at = put_big(at, (uint64_t)utime_us, 8);
    at = put_big(at, channel_size, 4);
    put_big(at, (uint64_t)size, 4);
    if (writer->output.reason != 0) {
        return; /* softsim_log_finish tells */
    }
    fwrite(head, sizeof head, 1, writer->output.file);
    fwrite(channel, 1, channel_size, writer->output.file);
    fwrite(data, 1, (size_t)size, writer->output.file);
    (void)ss_output_pace(&writer->output);
}

const char *softsim_log_path(const softsim_log_writer *writer)
{
    const ss_output *output = &writer->output;
    return output->temporary != NULL ? output->temporary : output->path;
}

const char *softsim_log_kept(const softsim_log_writer *writer)
{
    return writer->output.kept;
}

bool softsim_log_has_failed(const softsim_log_writer *writer)
{
    return writer->output.reason != 0;
}

void softsim_log_write_pose(softsim_log_writer *writer, int64_t utime_us, const char *channel,
                            const softsim_pose *pose)
{
    uint8_t data[SS_WIRE_POSE_SIZE];
    ss_wire_encode_pose(pose, data);
    softsim_log_write(writer, utime_us, channel, data, sizeof data);
}

void softsim_log_write_force(softsim_log_writer *writer, int64_t utime_us, const char *channel,
                             const softsim_force *force)
{
    uint8_t data[SS_WIRE_FORCE_SIZE];
    ss_wire_encode_force(force, data);
    softsim_log_write(writer, utime_us, channel, data, sizeof data);
}

softsim_status softsim_log_finish(softsim_log_writer **writer, softsim_error *error)
{
    if (*writer == NULL) {
        return SOFTSIM_OK;
    }
    const softsim_status status = ss_output_commit(&(*writer)->output, error);
    free(*writer);
    *writer = NULL;
    return status;
}

void softsim_log_keep(softsim_log_writer **writer, softsim_error *error)
{
    if (*writer != NULL) {
        ss_output_keep(&(*writer)->output, error);
        free(*writer);
        *writer = NULL;
    }
}

void softsim_log_abandon(softsim_log_writer **writer)
{
    if (*writer != NULL) {
        ss_output_abandon(&(*writer)->output);
        free(*writer);
        *writer = NULL;
    }
}
