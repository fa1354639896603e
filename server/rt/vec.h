/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Small double-precision vectors and unit quaternions (w x y z, tool to world). RT-safe. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define SS_PI 3.14159265358979323846

static inline void ss_set3(double out[3], double x, double y, double z)
{
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

static inline void ss_copy3(double out[3], const double a[3])
{
    ss_set3(out, a[0], a[1], a[2]);
}

static inline void ss_add3(double out[3], const double a[3], const double b[3])
{
    ss_set3(out, a[0] + b[0], a[1] + b[1], a[2] + b[2]);
}

static inline void ss_sub3(double out[3], const double a[3], const double b[3])
{
    ss_set3(out, a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

static inline void ss_scale3(double out[3], const double a[3], double s)
{
    ss_set3(out, s * a[0], s * a[1], s * a[2]);
}

/* out = a + s b */
static inline void ss_madd3(double out[3], const double a[3], double s, const double b[3])
{
    ss_set3(out, a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]);
}

static inline double ss_dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void ss_cross3(double out[3], const double a[3], const double b[3])
{
    ss_set3(out, a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

/* out = (b - a) x (c - a): the normal of a triangle, twice its area long. */
static inline void ss_normal3(double out[3], const double a[3], const double b[3],
                              const double c[3])
{
    double ab[3], ac[3];
    ss_sub3(ab, b, a);
    ss_sub3(ac, c, a);
    ss_cross3(out, ab, ac);
}

/* (b - a) . (c - a) x (d - a): six times the volume of a tetrahedron. */
static inline double ss_six_volumes3(const double a[3], const double b[3], const double c[3],
                                     const double d[3])
{
    double ab[3], normal[3];
    ss_sub3(ab, b, a);
    ss_normal3(normal, a, c, d);
    return ss_dot3(ab, normal);
}

static inline double ss_norm3(const double a[3])
{
    return sqrt(ss_dot3(a, a));
}

/* Shortens v to `limit` where it is longer; true when it was. */
static inline bool ss_clamp_norm3(double v[3], double limit)
{
    const double size = ss_norm3(v);
    if (size <= limit) {
        return false;
    }
    ss_scale3(v, v, limit / size);
    return true;
}

/* Brings v to within `limit` of `last` where it is further off; true when it was. */
static inline bool ss_clamp_change3(double v[3], const double last[3], double limit)
{
    double change[3];
    ss_sub3(change, v, last);
    if (!ss_clamp_norm3(change, limit)) {
        return false;
    }
    ss_add3(v, last, change);
    return true;
}

/* Normalises `a`; returns its length; leaves a zero vector as it is. */
static inline double ss_normalize3(double a[3])
{
    const double length = ss_norm3(a);
    if (length > 0.0) {
        ss_scale3(a, a, 1.0 / length);
    }
    return length;
}

static inline bool ss_is_finite(const double *values, int count)
{
    for (int i = 0; i < count; ++i) {
        if (!isfinite(values[i])) {
            return false;
        }
    }
    return true;
}

/* out = q v q*: a tool vector into the world. */
static inline void ss_rotate(double out[3], const double q[4], const double v[3])
{
    const double t[3] = {2.0 * (q[2] * v[2] - q[3] * v[1]), 2.0 * (q[3] * v[0] - q[1] * v[2]),
                         2.0 * (q[1] * v[1] - q[2] * v[0])};
    ss_set3(out, v[0] + q[0] * t[0] + q[2] * t[2] - q[3] * t[1],
            v[1] + q[0] * t[1] + q[3] * t[0] - q[1] * t[2],
            v[2] + q[0] * t[2] + q[1] * t[1] - q[2] * t[0]);
}

/* out = q* v q: a world vector into the tool. */
static inline void ss_rotate_back(double out[3], const double q[4], const double v[3])
{
    const double conjugate[4] = {q[0], -q[1], -q[2], -q[3]};
    ss_rotate(out, conjugate, v);
}

/* out = `q` (w x y z) turned by the rotation vector `turn` in the world. */
static inline void ss_turn(const double q[4], const double turn[3], double out[4])
{
    const double angle = ss_norm3(turn), w = cos(0.5 * angle);
    double v[3], cross[3];
    ss_scale3(v, turn, angle > 0.0 ? sin(0.5 * angle) / angle : 0.5);
    ss_cross3(cross, v, q + 1);
    out[0] = w * q[0] - ss_dot3(v, q + 1);
    for (int k = 0; k < 3; ++k) {
        out[k + 1] = w * q[k + 1] + q[0] * v[k] + cross[k];
    }
}

/* The rotation vector from orientation `a` to `b` (w x y z), the shorter way round, in the world:
 * of b a*. */
static inline void ss_turn_between(const double a[4], const double b[4], double out[3])
{
    const double w = b[0] * a[0] + b[1] * a[1] + b[2] * a[2] + b[3] * a[3];
    double v[3], cross[3];
    ss_cross3(cross, b + 1, a + 1);
    for (int k = 0; k < 3; ++k) {
        v[k] = a[0] * b[k + 1] - b[0] * a[k + 1] - cross[k];
    }
    const double sine = ss_norm3(v);
    const double angle = 2.0 * atan2(sine, fabs(w));
    ss_scale3(out, v, sine > 0.0 ? (w < 0.0 ? -angle : angle) / sine : 0.0);
}

/* The box around points; zeros without any. */
static inline void ss_bounds3(int32_t count, const double (*x)[3], double low[3], double high[3])
{
    ss_set3(low, 0.0, 0.0, 0.0);
    ss_set3(high, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            low[k] = i == 0 ? x[i][k] : fmin(low[k], x[i][k]);
            high[k] = i == 0 ? x[i][k] : fmax(high[k], x[i][k]);
        }
    }
}

/* x := (L L^T)^-1 x; rows of the factor L are `row` apart. */
static inline void ss_solve_cholesky(int32_t n, const double *factor, int32_t row, double *x)
{
    for (int32_t i = 0; i < n; ++i) {
        for (int32_t k = 0; k < i; ++k) {
            x[i] -= factor[i * row + k] * x[k];
        }
        x[i] /= factor[i * row + i];
    }
    for (int32_t i = n - 1; i >= 0; --i) {
        for (int32_t k = i + 1; k < n; ++k) {
            x[i] -= factor[k * row + i] * x[k];
        }
        x[i] /= factor[i * row + i];
    }
}

/* A rotation of two numbers, as Jacobi's method turns rows and columns. */
static inline void ss_rotate_pair(double *x, double *y, double cosine, double sine)
{
    const double before = *x;
    *x = cosine * before - sine * *y;
    *y = sine * before + cosine * *y;
}
