/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "simplex.h"

#include <math.h>
#include <string.h>

typedef struct corner {
    double x[SS_SIMPLEX_MAX], value;
} corner;

typedef struct state {
    const ss_simplex *s;
    corner corner[SS_SIMPLEX_MAX + 1]; /* best first */
    int32_t used;
} state;

static void ask(state *t, corner *c)
{
    for (int32_t k = 0; k < t->s->count; ++k) {
        c->x[k] = fmin(fmax(c->x[k], t->s->low[k]), t->s->high[k]);
    }
    ++t->used;
    c->value = t->s->value(t->s->context, c->x);
    if (isnan(c->value)) {
        c->value = (double)INFINITY;
    }
}

static void sort(state *t)
{
    for (int32_t i = 1; i <= t->s->count; ++i) {
        const corner at = t->corner[i];
        int32_t k = i;
        for (; k > 0 && at.value < t->corner[k - 1].value; --k) {
            t->corner[k] = t->corner[k - 1];
        }
        t->corner[k] = at;
    }
}

/* The point at `share` of the way from the worst corner through the middle of the others. */
static corner go(state *t, double share)
{
    const int32_t n = t->s->count;
    corner out = {.value = 0.0};
    for (int32_t k = 0; k < n; ++k) {
        double middle = 0.0;
        for (int32_t i = 0; i < n; ++i) {
            middle += t->corner[i].x[k] / n;
        }
        out.x[k] = middle + share * (middle - t->corner[n].x[k]);
    }
    ask(t, &out);
    return out;
}

static void shrink(state *t)
{
    for (int32_t i = 1; i <= t->s->count; ++i) {
        for (int32_t k = 0; k < t->s->count; ++k) {
            t->corner[i].x[k] = 0.5 * (t->corner[i].x[k] + t->corner[0].x[k]);
        }
        ask(t, &t->corner[i]);
    }
}

static void improve(state *t)
{
    const int32_t n = t->s->count;
    corner *worst = &t->corner[n];
    const corner reflected = go(t, 1.0);
    if (reflected.value < t->corner[0].value) {
        const corner expanded = go(t, 2.0);
        *worst = expanded.value < reflected.value ? expanded : reflected;
    } else if (reflected.value < t->corner[n - 1].value) {
        *worst = reflected;
    } else {
        const corner inner = go(t, reflected.value < worst->value ? 0.5 : -0.5);
        if (inner.value < fmin(worst->value, reflected.value)) {
            *worst = inner;
        } else {
            shrink(t);
        }
    }
}

double ss_simplex_minimise(const ss_simplex *simplex, double *x)
{
    const int32_t n = simplex->count;
    state t = {.s = simplex};
    for (int32_t i = 0; i <= n; ++i) {
        memcpy(t.corner[i].x, x, (size_t)n * sizeof *x);
        if (i > 0) {
            const int32_t k = i - 1;
            const bool is_up = x[k] + simplex->step <= simplex->high[k];
            t.corner[i].x[k] += is_up ? simplex->step : -simplex->step;
        }
        ask(&t, &t.corner[i]);
    }
    sort(&t);
    while (
        t.used < simplex->most && isfinite(t.corner[0].value) &&
        !(t.corner[n].value - t.corner[0].value <= simplex->tolerance * fabs(t.corner[0].value))) {
        improve(&t);
        sort(&t);
    }
    memcpy(x, t.corner[0].x, (size_t)n * sizeof *x);
    return t.corner[0].value;
}
