/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What a recording holds. cmocka comes first. */
#include "softsim/log.h"

/* How many whole records a log has; `out_rest`: bytes that belong to no record. */
static inline int count_records(const char *path, int64_t *out_rest)
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *log = NULL;
    softsim_log_event event;
    softsim_log_result result;
    int count = 0;
    *out_rest = 0;
    assert_int_equal(softsim_log_open(path, &log, &error), SOFTSIM_OK);
    while ((result = softsim_log_next(log, &event)) != SOFTSIM_LOG_END) {
        count += result == SOFTSIM_LOG_EVENT;
        *out_rest += result == SOFTSIM_LOG_EVENT ? 0 : event.skipped;
    }
    softsim_log_close(&log);
    return count;
}
