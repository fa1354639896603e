/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What an owner releases, in one statement: SS_EACH(ss_memory_free, d->node, d->face, d). In the
 * order they are named; NULL is handed on like the rest. Thread: that of `release`. */
#include <stddef.h>

#define SS_EACH(release, ...)                                                                      \
    ss_each((release), (void *const[]){__VA_ARGS__},                                               \
            sizeof((void *const[]){__VA_ARGS__}) / sizeof(void *))

static inline void ss_each(void (*release)(void *), void *const *memory, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        release(memory[i]);
    }
}
