/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How much of a test is run. The default suite has each claim once at a size that can fail it;
 * `tools/test.sh --long` (it sets SOFTSIM_TESTS_LONG, which is read here alone) runs the long forms
 * of all builds: full sizes, more seeds, more samples. IS_REPEATED: a build that looks for
 * something else (sanitizers, double precision) with the claims of release.
 */
#include <stdbool.h>
#include <stdlib.h>

static inline bool is_long_run(void)
{
    return getenv("SOFTSIM_TESTS_LONG") != NULL;
}

/* `full` in a long run and in release, `less` where release has run it before. */
#define FULL_IN_RELEASE(full, less) (is_long_run() || !IS_REPEATED ? (full) : (less))
/* `full` in a long run alone. */
#define FULL_IN_LONG_RUN(full, less) (is_long_run() ? (full) : (less))
/* First in a case that takes long and whose code other cases of its file run as well: those are
 * left to the build that looks for something else. cmocka comes first. */
#define SKIP_WHERE_REPEATED()                                                                      \
    do {                                                                                           \
        if (!FULL_IN_RELEASE(true, false)) {                                                       \
            skip();                                                                                \
        }                                                                                          \
    } while (0)
