/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * libFuzzer entry: any bytes as an event log. The reader must end, stay within memory, and
 * account for every byte: records and damage follow one another without gap or overlap.
 * Build: clang -fsanitize=fuzzer,address,undefined, with ss_client_log.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "softsim/log.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check_accounting(const char *path, size_t size)
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *log = NULL;
    if (softsim_log_open(path, &log, &error) != SOFTSIM_OK) {
        abort();
    }
    int64_t at = 0;
    softsim_log_event event;
    softsim_log_result result;
    while ((result = softsim_log_next(log, &event)) != SOFTSIM_LOG_END) {
        softsim_pose pose;
        int32_t channel_size = 0;
        if (event.offset != at || result == SOFTSIM_LOG_UNREADABLE) {
            abort();
        }
        if (result == SOFTSIM_LOG_EVENT) {
            while (event.channel[channel_size] != '\0') {
                ++channel_size;
            }
            at += 28 + channel_size + event.data_size;
            softsim_log_decode_pose(event.data, event.data_size, &pose);
            /* Touch all of it, for the address sanitizer. */
            uint8_t mix = 0;
            for (int32_t i = 0; event.data != NULL && i < event.data_size; ++i) {
                mix ^= event.data[i];
            }
            *(volatile uint8_t *)&mix;
        } else if (event.skipped < 1) {
            abort();
        } else {
            at += event.skipped;
        }
    }
    if (at != (int64_t)size) {
        abort();
    }
    softsim_log_close(&log);
}

static void check_poses(const char *path)
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_poses *poses = NULL;
    if (softsim_poses_open(path, 1000.0, &poses, &error) != SOFTSIM_OK) {
        return; /* bytes that look like a CSV and are not one */
    }
    softsim_pose_event event;
    char note[256];
    softsim_poses_result result;
    int64_t last_us = 0;
    int32_t left = 100000;
    while ((result = softsim_poses_next(poses, &event, note, sizeof note)) != SOFTSIM_POSES_END &&
           left-- > 0) {
        if (result == SOFTSIM_POSES_POSE) {
            if (event.time_us < last_us) {
                abort();
            }
            last_us = event.time_us;
        }
    }
    softsim_poses_close(&poses);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[64];
    const int fd = memfd_create("fuzz", 0);
    if (fd < 0 || write(fd, data, size) != (ssize_t)size) {
        abort();
    }
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    check_accounting(path, size);
    check_poses(path);
    close(fd);
    return 0;
}
