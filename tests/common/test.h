/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * cmocka's tests without a list of them: what is written TEST(name_of_the_claim) { ... } is run by
 * run_all_tests(), in the order in which a file has them. The body may use `state`, as cmocka hands
 * it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { MAX_TESTS = 128 }; /* of a file */

static struct CMUnitTest test_list[MAX_TESTS];
static int test_line[MAX_TESTS];
static size_t test_count;

static inline void add_test(int line, struct CMUnitTest test)
{
    size_t at = test_count++;
    if (at == MAX_TESTS) {
        __builtin_trap();
    }
    for (; at > 0 && test_line[at - 1] > line; --at) {
        test_list[at] = test_list[at - 1];
        test_line[at] = test_line[at - 1];
    }
    test_list[at] = test;
    test_line[at] = line;
}

/* `setup` and `teardown` as cmocka has them: around this test alone; NULL: none. */
#define TEST_WITH(name, setup, teardown)                                                           \
    static void name(void **state);                                                                \
    __attribute__((constructor)) static void add_##name(void)                                      \
    {                                                                                              \
        add_test(__LINE__, (struct CMUnitTest){#name, name, setup, teardown, NULL});               \
    }                                                                                              \
    static void name(__attribute__((unused)) void **state)
#define TEST(name) TEST_WITH(name, NULL, NULL)

/* Rows of tables: what is given, and a part of what is said to it. */
typedef struct says_row {
    const char *given, *says;
} says_row;
typedef struct call_row {
    const char *program, *options;
} call_row;
typedef struct program_row {
    const char *program, *options, *says;
} program_row;

/* The last statement of every main: `setup` and `teardown` around all of the file's tests. */
static inline int run_all_tests(CMFixtureFunction setup, CMFixtureFunction teardown)
{
    return _cmocka_run_group_tests("tests", test_list, test_count, setup, teardown);
}
