/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/body_state.h"
/*
 * Passes over all nodes of a body: a few operations on each number that is read, so that memory
 * decides, not the width of the registers; one path for all processors. Sums run in the lanes
 * over a block of nodes and in double over the blocks, in a fixed order.
 */
#include <math.h>

#include "models/common/wide.h"

enum { BLOCK = SS_BODY_BLOCK };

static int32_t block_end(int32_t first, int32_t count)
{
    return first + BLOCK < count ? first + BLOCK : count;
}

static ss_real lane_most(ss_pair a)
{
    _Alignas(32) ss_real lane[4];
    ss_quad_store(lane, ss_pair_fold(a));
    ss_real most = lane[0];
    for (int k = 1; k < 4; ++k) {
        most = lane[k] > most ? lane[k] : most;
    }
    return most;
}

/* What a kick did to v: v := keep v + gain mobility force. */
typedef struct kick {
    double keep, gain;
    const ss_real *mobility, *force;
} kick;

/* The nodes of a block that are too fast, one by one. Energy lost: the impulse that is lost times
 * the mean of the velocities before and after, as the energy balance counts every force. */
static void slow_down(int32_t first, int32_t end, double limit, const kick *by, const double *mass,
                      ss_real *v, ss_body_speed *out)
{
    for (int32_t i = first; i < end; ++i) {
        const ptrdiff_t node = 4 * (ptrdiff_t)i;
        const double x = (double)v[node], y = (double)v[node + 1], z = (double)v[node + 2];
        const double length = sqrt(x * x + y * y + z * z);
        for (ptrdiff_t at = node; length > limit && at < node + 3; ++at) {
            const double light = (double)by->mobility[at];
            if (light > 0.0) {
                const double fast = (double)v[at];
                const double before =
                    by->keep != 0.0 ? (fast - by->gain * light * (double)by->force[at]) / by->keep
                                    : 0.0;
                v[at] = (ss_real)(fast * (limit / length));
                out->is_slowed = true;
                out->loss += 0.5 * mass[i] * (fast - (double)v[at]) * (before + (double)v[at]);
            }
        }
    }
}

ss_body_speed ss_body_kick_drift(const ss_body_nodes *nodes, const uint8_t *is_idle,
                                 const ss_body_kick *how, double h, double limit,
                                 const ss_real *mass, ss_real *v, ss_real *u)
{
    const int32_t count = nodes->padded_count;
    const ss_real *mobility = nodes->mobility, *force = nodes->force;
    const double left = 1.0 - how->ahead * how->damping;
    const double share = 1.0 / (1.0 + how->lag * how->damping);
    const ss_pair behind = ss_pair_all((ss_real)how->lag), ahead = ss_pair_all((ss_real)how->ahead);
    const ss_pair shared = ss_pair_all((ss_real)share), kept = ss_pair_all((ss_real)left);
    const ss_pair step = ss_pair_all((ss_real)h);
    const double near = limit * limit / 3.0; /* below: no component can make it too fast */
    const kick by = {.keep = left * share,
                     .gain = left * share * how->lag + how->ahead,
                     .mobility = mobility,
                     .force = force};
    ss_body_speed speed = {0};
    for (int32_t first = 0; first < count; first = block_end(first, count)) {
        if (is_idle[first / BLOCK]) {
            continue;
        }
        const int32_t end = block_end(first, count);
        ss_pair square = ss_pair_all(0), most = ss_pair_all(0), moving = ss_pair_all(0);
        for (int32_t i = first; i < end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_pair light = ss_pair_load(mobility + at), m = ss_pair_each(mass + i);
            const ss_pair push = ss_pair_mul(light, ss_pair_load(force + at));
            const ss_pair w = ss_pair_mul(shared, ss_pair_fma(behind, push, ss_pair_load(v + at)));
            const ss_pair next = ss_pair_fma(ahead, push, ss_pair_mul(kept, w));
            /* m on axes that may move, 0 elsewhere */
            moving = ss_pair_fma(ss_pair_mul(ss_pair_mul(light, m), m), ss_pair_mul(w, w), moving);
            most = ss_pair_most(ss_pair_mul(next, next), most);
            ss_pair_store(v + at, next);
        }
        if ((double)lane_most(most) > near) {
            slow_down(first, end, limit, &by, nodes->mass, v, &speed);
        }
        for (ptrdiff_t at = 4 * (ptrdiff_t)first; at < 4 * (ptrdiff_t)end; at += 8) {
            const ss_pair w = ss_pair_load(v + at);
            square = ss_pair_fma(w, w, square);
            ss_pair_store(u + at, ss_pair_fma(step, w, ss_pair_load(u + at)));
        }
        speed.square += ss_pair_sum(square);
        speed.twice_kinetic += ss_pair_sum(moving);
    }
    return speed;
}

void ss_body_rates(int32_t count, double damping, const ss_real *mobility, const ss_real *force,
                   const ss_real *v, ss_real *out_rate)
{
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)count; ++at) {
        const ss_real loss = mobility[at] > 0 ? (ss_real)damping * v[at] : 0;
        out_rate[at] = mobility[at] * force[at] - loss;
    }
}

void ss_body_axpy(int32_t count, double s, const ss_real *x, ss_real *y)
{
    const ss_pair factor = ss_pair_all((ss_real)s);
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)count; at += 8) {
        ss_pair_store(y + at, ss_pair_fma(factor, ss_pair_load(x + at), ss_pair_load(y + at)));
    }
}

void ss_body_blend(int32_t count, const ss_real *x, double s, const ss_real *y, ss_real *out)
{
    const ss_pair factor = ss_pair_all((ss_real)s);
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)count; at += 8) {
        ss_pair_store(out + at, ss_pair_fma(factor, ss_pair_load(y + at), ss_pair_load(x + at)));
    }
}

double ss_body_dot(int32_t count, const ss_real *x, const ss_real *y)
{
    double sum = 0.0;
    for (int32_t first = 0; first < count; first = block_end(first, count)) {
        const ptrdiff_t end = 4 * (ptrdiff_t)block_end(first, count);
        ss_pair lanes = ss_pair_all(0);
        for (ptrdiff_t at = 4 * (ptrdiff_t)first; at < end; at += 8) {
            lanes = ss_pair_fma(ss_pair_load(x + at), ss_pair_load(y + at), lanes);
        }
        sum += ss_pair_sum(lanes);
    }
    return sum;
}

double ss_body_square(int32_t count, const ss_real *v)
{
    return ss_body_dot(count, v, v);
}

void ss_body_motion(const ss_body_nodes *nodes, const uint8_t *is_idle, double lag, double damping,
                    const ss_real *mass, const ss_real *v, double *out_twice_kinetic,
                    double *out_rate)
{
    const int32_t count = nodes->padded_count;
    const ss_real *mobility = nodes->mobility, *force = nodes->force;
    const ss_pair share = ss_pair_all((ss_real)(1.0 / (1.0 + lag * damping)));
    const ss_pair behind = ss_pair_all((ss_real)lag), loss = ss_pair_all((ss_real)damping);
    *out_twice_kinetic = *out_rate = 0.0;
    for (int32_t first = 0; first < count; first = block_end(first, count)) {
        if (is_idle[first / BLOCK]) {
            continue;
        }
        const int32_t end = block_end(first, count);
        ss_pair square = ss_pair_all(0), rate = ss_pair_all(0);
        for (int32_t i = first; i < end; i += 2) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const ss_pair light = ss_pair_load(mobility + at), heavy = ss_pair_each(mass + i);
            const ss_pair push = ss_pair_mul(light, ss_pair_load(force + at));
            const ss_pair w = ss_pair_mul(share, ss_pair_fma(behind, push, ss_pair_load(v + at)));
            const ss_pair a = ss_pair_fnma(loss, w, push);
            /* m on axes that may move, 0 elsewhere */
            const ss_pair m = ss_pair_mul(ss_pair_mul(light, heavy), heavy);
            square = ss_pair_fma(m, ss_pair_mul(w, w), square);
            rate = ss_pair_fma(m, ss_pair_mul(a, a), rate);
        }
        *out_twice_kinetic += ss_pair_sum(square);
        *out_rate += ss_pair_sum(rate);
    }
}

double ss_body_largest(int32_t count, const ss_real *u)
{
    double largest = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        const ss_real *p = u + 4 * (ptrdiff_t)i;
        const double square = (double)(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        largest = square > largest ? square : largest;
    }
    return largest;
}
