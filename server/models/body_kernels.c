/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/body_state.h"
/*
 * Passes over all nodes of a body: a few operations on each number that is read, so that memory
 * decides, not the width of the registers; one path for all processors. Sums run in the lanes
 * over a block of nodes and in double over the blocks, in a fixed order.
 */
#include <math.h>

#include "models/wide.h"

enum { BLOCK = 64 }; /* nodes */

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

/* The nodes of a block that are too fast, one by one; returns the energy taken. */
static double slow_down(int32_t first, int32_t end, double limit, const ss_real *mobility,
                        const double *mass, ss_real *v)
{
    double taken = 0.0;
    for (int32_t i = first; i < end; ++i) {
        ss_real *w = v + 4 * (ptrdiff_t)i;
        const ss_real *m = mobility + 4 * (ptrdiff_t)i;
        const double x = (double)w[0], y = (double)w[1], z = (double)w[2];
        const double square = x * x + y * y + z * z;
        if (!(square > limit * limit) || (m[0] == 0 && m[1] == 0 && m[2] == 0)) {
            continue;
        }
        const double factor = limit / sqrt(square);
        for (int k = 0; k < 3; ++k) {
            if (m[k] > 0) {
                const double before = (double)w[k];
                w[k] = (ss_real)(before * factor);
                taken += 0.5 * mass[i] * (before * before - (double)w[k] * (double)w[k]);
            }
        }
    }
    return taken;
}

double ss_body_kick_drift(int32_t count, double keep, double gain, double h, double limit,
                          const ss_real *mobility, const ss_real *force, const double *mass,
                          ss_real *v, ss_real *u, double *out_slowed)
{
    const ss_pair kept = ss_pair_all((ss_real)keep), gained = ss_pair_all((ss_real)gain);
    const ss_pair step = ss_pair_all((ss_real)h);
    const double near = limit * limit / 3.0; /* below: no component can make it too fast */
    double sum = 0.0;
    *out_slowed = 0.0;
    for (int32_t first = 0; first < count; first = block_end(first, count)) {
        const int32_t end = block_end(first, count);
        ss_pair square = ss_pair_all(0), most = ss_pair_all(0);
        for (ptrdiff_t at = 4 * (ptrdiff_t)first; at < 4 * (ptrdiff_t)end; at += 8) {
            const ss_pair push = ss_pair_mul(ss_pair_load(mobility + at), ss_pair_load(force + at));
            const ss_pair w = ss_pair_fma(gained, push, ss_pair_mul(kept, ss_pair_load(v + at)));
            most = ss_pair_most(ss_pair_mul(w, w), most);
            ss_pair_store(v + at, w);
        }
        if ((double)lane_most(most) > near) {
            *out_slowed += slow_down(first, end, limit, mobility, mass, v);
        }
        for (ptrdiff_t at = 4 * (ptrdiff_t)first; at < 4 * (ptrdiff_t)end; at += 8) {
            const ss_pair w = ss_pair_load(v + at);
            square = ss_pair_fma(w, w, square);
            ss_pair_store(u + at, ss_pair_fma(step, w, ss_pair_load(u + at)));
        }
        sum += ss_pair_sum(square);
    }
    return sum;
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

void ss_body_motion(int32_t count, double lag, double damping, const ss_real *mobility,
                    const ss_real *mass, const ss_real *force, const ss_real *v, double *out_square,
                    double *out_rate)
{
    const ss_pair share = ss_pair_all((ss_real)(1.0 / (1.0 + lag * damping)));
    const ss_pair behind = ss_pair_all((ss_real)lag), loss = ss_pair_all((ss_real)damping);
    *out_square = *out_rate = 0.0;
    for (int32_t first = 0; first < count; first = block_end(first, count)) {
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
        *out_square += ss_pair_sum(square);
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
