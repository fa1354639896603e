/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The coupling between hand and proxy, and the balance of the proxy.
 *
 * The proxy p has no mass. A spring K_c and damper B_c tie it to the pose x with velocity v; with
 * pdot = (p - p-)/T it would rest, free of contact, at
 *   p_f = (K_c x + B_c v + (B_c/T) p-) / (K_c + B_c/T)
 * and against contacts F_i(p) = max(0, b_i - k'_i n_i.(p - p_f)) it rests where
 *   K (p - p_f) = sum F_i(p) n_i,   K = K_c + B_c/T,
 * which is the minimum of K/2 |p - p_f|^2 + sum F_i(p)^2 / (2 k'_i): strictly convex, one answer,
 * continuous in all its data, so that first touch, leaving and touching again need no case of
 * their own. Given the active contacts it is a 3 x 3 system in d = p - p_f,
 *   (K I + sum k'_i n_i n_i^T) d = sum b_i n_i,
 * solved by Cholesky; the active set is then read off F_i > 0 and the solve repeated. This is
 * Newton on a piecewise quadratic; going to the least point on the way whenever the set changed
 * keeps it from circling (1 in 10^4 of random sets of eight opposed contacts did).
 *
 * K_c yields only as much as stability needs: 1/K_c = max(1/20000, 1/K_max - 1/k), hence the felt
 * stiffness K_c k/(K_c + k) is min(k, K_max), nearly.
 *
 * Rejected: a proxy with mass (one more state, no better feel, hands out energy) and a rigid
 * constraint to the last surface (chatters: the surface is a period old).
 */
#include "haptic/internal.h"

#include "rt/vec.h"

/* Stiffest coupling, N/m: stiffer gains nothing that a hand feels and costs digits. */
#define STIFFEST 20000.0

void ss_coupling_solve(double a[3][3], const double b[3], double out[3])
{
    /* a = L L^T, row by row. */
    const double l00 = sqrt(a[0][0]);
    const double l10 = a[1][0] / l00;
    const double l20 = a[2][0] / l00;
    const double l11 = sqrt(a[1][1] - l10 * l10);
    const double l21 = (a[2][1] - l20 * l10) / l11;
    const double l22 = sqrt(a[2][2] - l20 * l20 - l21 * l21);
    const double y0 = b[0] / l00;
    const double y1 = (b[1] - l10 * y0) / l11;
    const double y2 = (b[2] - l20 * y0 - l21 * y1) / l22;
    out[2] = y2 / l22;
    out[1] = (y1 - l21 * out[2]) / l11;
    out[0] = (y0 - l10 * out[1] - l20 * out[2]) / l00;
}

double ss_coupling_largest(double m[3][3])
{
    /* Characteristic polynomial by angle (Smith 1961): m = q I + s B with tr B = 0, |B| = sqrt 6.
     */
    const double off = m[0][1] * m[0][1] + m[0][2] * m[0][2] + m[1][2] * m[1][2];
    const double q = (m[0][0] + m[1][1] + m[2][2]) / 3.0;
    const double d0 = m[0][0] - q;
    const double d1 = m[1][1] - q;
    const double d2 = m[2][2] - q;
    const double s = sqrt((d0 * d0 + d1 * d1 + d2 * d2 + 2.0 * off) / 6.0);
    if (s <= 1e-12 * fabs(q) || s == 0.0) {
        return q;
    }
    const double b0 = d0 / s;
    const double b1 = d1 / s;
    const double b2 = d2 / s;
    const double b01 = m[0][1] / s;
    const double b02 = m[0][2] / s;
    const double b12 = m[1][2] / s;
    const double half_det = 0.5 * (b0 * (b1 * b2 - b12 * b12) - b01 * (b01 * b2 - b12 * b02) +
                                   b02 * (b01 * b12 - b1 * b02));
    const double angle = acos(fmin(1.0, fmax(-1.0, half_det))) / 3.0;
    return q + 2.0 * s * cos(angle);
}

double ss_coupling_spring(double limit, double k)
{
    const double compliance = 1.0 / limit - (k > 0.0 ? 1.0 / k : 0.0);
    return 1.0 / fmax(1.0 / STIFFEST, compliance);
}

/* The forces at p_free + d. */
static void evaluate(const ss_balance *balance, const double d[3], double out_force[],
                     double out_held[3])
{
    for (int32_t i = 0; i < balance->count; ++i) {
        const ss_balance_row *row = &balance->row[i];
        out_force[i] = fmax(0.0, row->free_force - row->slope * ss_dot3(row->normal, d));
    }
    ss_set3(out_held, 0.0, 0.0, 0.0);
    if (balance->is_held) {
        for (int r = 0; r < 3; ++r) {
            out_held[r] = balance->held_force[r] - ss_dot3(balance->held_slope[r], d);
        }
    }
}

void ss_coupling_evaluate(const ss_balance *balance, const double p[3], double out_force[],
                          double out_held[3])
{
    double d[3];
    ss_sub3(d, p, balance->p_free);
    evaluate(balance, d, out_force, out_held);
}

static uint32_t active_rows(const ss_balance *balance, const double force[])
{
    uint32_t active = 0;
    for (int32_t i = 0; i < balance->count; ++i) {
        active |= force[i] > 0.0 ? 1U << i : 0U;
    }
    return active;
}

/* Adds slope n n^T. */
static void add_outer(double a[3][3], double slope, const double n[3])
{
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            a[r][c] += slope * n[r] * n[c];
        }
    }
}

/* The law's own slope: the active rows (bits of `active`) and the grasp. */
static void law_slope(const ss_balance *balance, uint32_t active, double a[3][3])
{
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            a[r][c] = balance->is_held ? balance->held_slope[r][c] : 0.0;
        }
    }
    for (int32_t i = 0; i < balance->count; ++i) {
        if (active & (1U << i)) {
            add_outer(a, balance->row[i].slope, balance->row[i].normal);
        }
    }
}

void ss_coupling_slip(const ss_balance *balance, const double force[], const double change[3],
                      double p[3])
{
    double a[3][3];
    law_slope(balance, active_rows(balance, force), a);
    /* `change` lies in the range of `a` when the law alone made it; the small diagonal only
     * completes the rank. A law without stiffness cannot be slipped out of. */
    const double trace = a[0][0] + a[1][1] + a[2][2];
    if (!(trace > 0.0)) {
        return;
    }
    for (int r = 0; r < 3; ++r) {
        a[r][r] += 1e-8 * trace;
    }
    double d[3];
    ss_coupling_solve(a, change, d);
    ss_add3(p, p, d);
}

/* Slope of the balance's potential along s at d: K d.s - sum F_i(d) n_i.s - held(d).s */
static double slope_along(const ss_balance *balance, const double d[3], const double s[3])
{
    double force[SS_MAX_CONTACTS], held[3];
    evaluate(balance, d, force, held);
    double slope = balance->spring * ss_dot3(d, s) - ss_dot3(held, s);
    for (int32_t i = 0; i < balance->count; ++i) {
        slope -= force[i] * ss_dot3(balance->row[i].normal, s);
    }
    return slope;
}

/* Where on the way from d to d + s the potential is least: its slope is piecewise linear and
 * grows, with kinks where a contact begins or ends. */
static double least_along(const ss_balance *balance, const double d[3], const double s[3])
{
    double kink[SS_MAX_CONTACTS + 1];
    int count = 0;
    for (int32_t i = 0; i < balance->count; ++i) {
        const ss_balance_row *row = &balance->row[i];
        const double fall = row->slope * ss_dot3(row->normal, s);
        const double t = (row->free_force - row->slope * ss_dot3(row->normal, d)) / fall;
        if (t > 0.0 && t < 1.0) {
            int at = count++;
            for (; at > 0 && kink[at - 1] > t; --at) {
                kink[at] = kink[at - 1];
            }
            kink[at] = t;
        }
    }
    kink[count++] = 1.0;
    double before = 0.0;
    double slope_before = slope_along(balance, d, s);
    for (int i = 0; i < count; ++i) {
        double at[3];
        ss_madd3(at, d, kink[i], s);
        const double slope = slope_along(balance, at, s);
        if (slope > 0.0) {
            const double share = -slope_before / (slope - slope_before);
            return before + fmin(1.0, fmax(0.0, share)) * (kink[i] - before);
        }
        before = kink[i];
        slope_before = slope;
    }
    return 1.0;
}

/* The proxy's displacement d when exactly the `active` contacts push. */
static void solve_active(const ss_balance *balance, uint32_t active, double out_d[3])
{
    double a[3][3];
    double b[3] = {0.0, 0.0, 0.0};
    law_slope(balance, active, a);
    for (int r = 0; r < 3; ++r) {
        a[r][r] += balance->spring;
        b[r] = balance->is_held ? balance->held_force[r] : 0.0;
    }
    for (int32_t i = 0; i < balance->count; ++i) {
        if (active & (1U << i)) {
            ss_madd3(b, b, balance->row[i].free_force, balance->row[i].normal);
        }
    }
    ss_coupling_solve(a, b, out_d);
}

int ss_coupling_balance(const ss_balance *balance, double out_p[3], double out_force[],
                        double out_held[3])
{
    double d[3] = {0.0, 0.0, 0.0};
    evaluate(balance, d, out_force, out_held);
    int pass = 0;
    for (bool is_settled = false; !is_settled && pass < SS_BALANCE_PASSES; ++pass) {
        const uint32_t active = active_rows(balance, out_force);
        double next[3];
        solve_active(balance, active, next);
        evaluate(balance, next, out_force, out_held);
        is_settled = active_rows(balance, out_force) == active;
        if (!is_settled) {
            double step[3];
            ss_sub3(step, next, d);
            ss_madd3(next, d, least_along(balance, d, step), step);
            evaluate(balance, next, out_force, out_held);
        }
        ss_copy3(d, next);
    }
    ss_add3(out_p, balance->p_free, d);
    return pass;
}
