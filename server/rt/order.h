/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What comes before what, for qsort and bsearch: -1 before, 1 after, 0 the same. A NaN is the same
 * as everything. RT-safe. */
#include <stdint.h>

static inline int ss_order_double(double a, double b)
{
    return (a > b) - (a < b);
}

static inline int ss_order_int(int64_t a, int64_t b)
{
    return (a > b) - (a < b);
}

static inline int ss_order_bits(uint64_t a, uint64_t b)
{
    return (a > b) - (a < b);
}

/* By `first`, and by `second` where that is the same. */
static inline int ss_order_then(int first, int second)
{
    return first != 0 ? first : second;
}

/* By the first of `count` numbers that differs. */
static inline int ss_order_ints(const int32_t *a, const int32_t *b, int count)
{
    int order = 0;
    for (int k = 0; k < count && order == 0; ++k) {
        order = ss_order_int(a[k], b[k]);
    }
    return order;
}

/* Something by what it is sorted by, and where that is the same by its number. */
typedef struct ss_keyed {
    double key;
    int32_t index;
} ss_keyed;

static inline int ss_compare_keyed(const void *left, const void *right)
{
    const ss_keyed *a = left, *b = right;
    return ss_order_then(ss_order_double(a->key, b->key), ss_order_int(a->index, b->index));
}

/* Ascending numbers, as qsort takes its function. */
static inline int ss_compare_doubles(const void *left, const void *right)
{
    return ss_order_double(*(const double *)left, *(const double *)right);
}

static inline int ss_compare_ints(const void *left, const void *right)
{
    return ss_order_int(*(const int32_t *)left, *(const int32_t *)right);
}
