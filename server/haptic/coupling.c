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
 * The spring holds at most the limit L (haptic.max_force_n). Where the force on the hand
 * F = sum F_i n_i + R would exceed it (R: forces that act whatever the proxy does), the spring
 * softens along the unit vector e of the local contact model's force, from K to 1/c, until |F| = L:
 *   (K (I - e e^T) + e e^T / c) d = G(d) = sum F_i n_i,   |G + R| = L,
 * e that of the tick before, or of this one where the limit is only just reached. The proxy slips
 * out of the tissue along the force until the contacts, be it one or eight, exert L: what the
 * model is stepped to is pressed with the limit and no more. Without R this is the least point of
 * the same potential with the spring's part along e continued as L |d.e| + const beyond L/K (Huber
 * 1964): still convex, one answer, continuous in all data, the same on the way in and out. In c,
 *   dG/dc = -A (M + A)^-1 e (e.d) / c^2,   A = sum k'_i n_i n_i^T,  M the spring's matrix,
 * and 1/|F| is a straight line for one contact, concave for several: Newton on 1/|F(c)| = 1/L from
 * c = 1/K needs one step there and a few else; a bracket guards it against the kinks where
 * contacts begin or end (as More and Sorensen 1983 for the step of a trust region). Where contacts
 * across e alone exceed the limit the spring softens all ways; where that does not help, against R
 * or a law without stiffness, the proxy stays with the stiff spring and the force is cut.
 *
 * Across e the spring stays stiff: the proxy goes sideways with the hand, beside it by as much as
 * the slip left it, and that part fades in 0.1 s (haptic.c), so that in the end the force points
 * from the hand to the proxy. A spring that is softened all ways puts the proxy on the point of the
 * surface nearest to the hand at once. Below the centre of curvature (16 mm in a kidney) the
 * nearest surface point is not unique: the direction turned by 30 to 90 degrees a tick.
 *
 * In a grasp it is softened all ways nevertheless, s K (p - p_f) = G: what is held is drawn back to
 * one place whichever way, the nearest point is unique, and the force turns as the hand goes round
 * that place, as without a limit. A spring that is stiff across e drags the proxy by dx, the hand's
 * way in the tick, and turns the force by k' dx / L (a kidney, k' = 1 kN/m, .2 N, .1 m/s: half a
 * radian). e follows a tick late, the line along it misses the places where |G| = L, and the tissue
 * answers later still: the force went to and fro by up to 90 degrees, every few ticks.
 *
 * K_c yields only as much as stability needs: 1/K_c = max(1/20000, 1/K_max - 1/k), hence the felt
 * stiffness K_c k/(K_c + k) is min(k, K_max), nearly.
 *
 * Rejected: a proxy with mass (one more state, no better feel, hands out energy), a rigid
 * constraint to the last surface (chatters: the surface is a period old), and cutting the force
 * after the balance and moving the proxy to where the local contact model exerts what is left (the
 * local contact model is stiff along its normals only: what it cannot give sends the proxy away).
 */
#include "haptic/internal.h"

#include <string.h>

#include "rt/vec.h"

/* m: a slip, L c, beyond this is none: the local contact model has no stiffness against the force.
 */
#define MAX_SLIP 10.0
/* Of the limit: how near the force comes to it. */
#define LIMIT_TOLERANCE 1e-9

void ss_cholesky_solve3(double a[3][3], const double b[3], double out[3])
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

double ss_max_eigenvalue3(double m[3][3])
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
    return 1.0 / fmax(1.0 / SS_MAX_COUPLING_STIFFNESS, compliance);
}

/* The coupling's spring: `along` the axis, `across` it. */
typedef struct coupling_spring {
    double along, across; /* N/m */
    const double *axis;   /* unit */
} coupling_spring;

/* The forces at p_free + d. */
static void evaluate(const ss_balance *balance, const double d[3], double out_force[],
                     double out_grasp[3])
{
    for (int32_t i = 0; i < balance->count; ++i) {
        const ss_balance_row *row = &balance->row[i];
        out_force[i] = fmax(0.0, row->free_force - row->slope * ss_dot3(row->normal, d));
    }
    ss_set3(out_grasp, 0.0, 0.0, 0.0);
    if (balance->is_held) {
        for (int r = 0; r < 3; ++r) {
            out_grasp[r] = balance->grasp_force[r] - ss_dot3(balance->grasp_slope[r], d);
        }
    }
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

/* The local contact model's own slope: the active rows (bits of `active`) and the grasp. */
static void local_slope(const ss_balance *balance, uint32_t active, double a[3][3])
{
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            a[r][c] = balance->is_held ? balance->grasp_slope[r][c] : 0.0;
        }
    }
    for (int32_t i = 0; i < balance->count; ++i) {
        if (active & (1U << i)) {
            add_outer(a, balance->row[i].slope, balance->row[i].normal);
        }
    }
}

/* Slope of the balance's potential along s at d: s.K d - sum F_i(d) n_i.s - grasp(d).s */
static double slope_along(const ss_balance *balance, const coupling_spring *spring,
                          const double d[3], const double s[3])
{
    double force[SS_MAX_CONTACTS], grasp[3];
    evaluate(balance, d, force, grasp);
    double slope =
        spring->across * ss_dot3(d, s) - ss_dot3(grasp, s) +
        (spring->along - spring->across) * ss_dot3(d, spring->axis) * ss_dot3(s, spring->axis);
    for (int32_t i = 0; i < balance->count; ++i) {
        slope -= force[i] * ss_dot3(balance->row[i].normal, s);
    }
    return slope;
}

/* Where on the way from d to d + s the potential is least: its slope is piecewise linear and
 * grows, with kinks where a contact begins or ends. */
static double least_along(const ss_balance *balance, const coupling_spring *spring,
                          const double d[3], const double s[3])
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
    double slope_before = slope_along(balance, spring, d, s);
    for (int i = 0; i < count; ++i) {
        double at[3];
        ss_madd3(at, d, kink[i], s);
        const double slope = slope_along(balance, spring, at, s);
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
static void solve_active(const ss_balance *balance, const coupling_spring *spring, uint32_t active,
                         double out_d[3])
{
    double a[3][3];
    double b[3] = {0.0, 0.0, 0.0};
    local_slope(balance, active, a);
    for (int r = 0; r < 3; ++r) {
        a[r][r] += spring->across;
        b[r] = balance->is_held ? balance->grasp_force[r] : 0.0;
    }
    add_outer(a, spring->along - spring->across, spring->axis);
    for (int32_t i = 0; i < balance->count; ++i) {
        if (active & (1U << i)) {
            ss_madd3(b, b, balance->row[i].free_force, balance->row[i].normal);
        }
    }
    ss_cholesky_solve3(a, b, out_d);
}

/* Balances `spring` from displacement `d` on; returns the passes. */
static int solve_balance(const ss_balance *balance, const coupling_spring *spring, double d[3],
                         ss_rest *rest)
{
    evaluate(balance, d, rest->force, rest->grasp);
    int pass = 0;
    for (bool is_settled = false; !is_settled && pass < SS_BALANCE_PASSES; ++pass) {
        const uint32_t active = active_rows(balance, rest->force);
        double next[3];
        solve_active(balance, spring, active, next);
        evaluate(balance, next, rest->force, rest->grasp);
        is_settled = active_rows(balance, rest->force) == active;
        if (!is_settled) {
            double step[3];
            ss_sub3(step, next, d);
            ss_madd3(next, d, least_along(balance, spring, d, step), step);
            evaluate(balance, next, rest->force, rest->grasp);
        }
        ss_copy3(d, next);
    }
    return pass;
}

/* G = sum F_i n_i, and F on the hand; returns |F|. */
static double sum_forces(const ss_balance *balance, const ss_rest *rest, double out_local[3],
                         double out_whole[3])
{
    ss_copy3(out_local, rest->grasp);
    for (int32_t i = 0; i < balance->count; ++i) {
        ss_madd3(out_local, out_local, rest->force[i], balance->row[i].normal);
    }
    ss_add3(out_whole, out_local, balance->other);
    return ss_norm3(out_whole);
}

/* -d|F|/dc of a spring with compliance c along its axis (or all ways: then along the force). */
static double force_decrease_rate(const ss_balance *balance, const ss_rest *rest,
                                  const coupling_spring *spring, const double d[3],
                                  const double whole[3], double size)
{
    double a[3][3], local[3][3], rhs[3], solution[3], force_rate[3];
    const bool is_isotropic = spring->along == spring->across;
    local_slope(balance, active_rows(balance, rest->force), local);
    memcpy(a, local, sizeof a);
    for (int r = 0; r < 3; ++r) {
        a[r][r] += spring->across;
    }
    add_outer(a, spring->along - spring->across, spring->axis);
    ss_scale3(rhs, spring->axis, ss_dot3(spring->axis, d));
    ss_scale3(rhs, is_isotropic ? d : rhs, spring->along * spring->along);
    ss_cholesky_solve3(a, rhs, solution);
    for (int r = 0; r < 3; ++r) {
        force_rate[r] = ss_dot3(local[r], solution);
    }
    return ss_dot3(whole, force_rate) / size;
}

/* Softens the spring from displacement `d` on, along its axis or all ways, until the force is the
 * limit; adds the passes. False when no softness brings it there. */
static bool soften(const ss_balance *balance, const double axis[3], bool is_isotropic, double d[3],
                   ss_rest *rest, int *inout_passes)
{
    const double limit = balance->limit;
    const double stiffest = 1.0 / balance->spring;
    const double softest = fmax(2.0 * stiffest, MAX_SLIP / limit);
    double low = stiffest, high = INFINITY, c = stiffest;
    coupling_spring spring = {balance->spring, balance->spring, axis};
    for (int i = 0; i < SS_LIMIT_TRIES; ++i) {
        double local[3], whole[3];
        const double size = sum_forces(balance, rest, local, whole);
        if (fabs(size - limit) <= LIMIT_TOLERANCE * limit) {
            return true;
        }
        if (size > limit && c >= softest) {
            return false;
        }
        *(size > limit ? &low : &high) = c;
        const double rate = force_decrease_rate(balance, rest, &spring, d, whole, size);
        const double newton = c + size * (size - limit) / (limit * rate);
        const double middle = high < INFINITY ? sqrt(low * high) : softest;
        c = newton > low && newton < fmin(high, softest) ? newton : middle;
        spring.along = 1.0 / c;
        spring.across = is_isotropic ? spring.along : spring.across;
        rest->stiffness_fraction = stiffest / c;
        *inout_passes += solve_balance(balance, &spring, d, rest);
    }
    return true;
}

int ss_coupling_balance(const ss_balance *balance, ss_rest *out_rest)
{
    double d[3] = {0.0, 0.0, 0.0}, axis[3] = {0.0, 0.0, 0.0}, start[3], whole[3];
    const coupling_spring spring = {balance->spring, balance->spring, axis};
    int passes = solve_balance(balance, &spring, d, out_rest);
    bool is_along_axis = true;
    out_rest->stiffness_fraction = 1.0;
    if (sum_forces(balance, out_rest, axis, whole) > balance->limit) {
        const ss_rest stiff = *out_rest;
        ss_copy3(start, d);
        if (ss_dot3(balance->axis, axis) > 0.0) {
            ss_copy3(axis, balance->axis);
        }
        (void)ss_normalize3(axis);
        bool is_soft = !balance->is_held && soften(balance, axis, false, d, out_rest, &passes);
        if (!is_soft) {
            *out_rest = stiff;
            ss_copy3(d, start);
            is_soft = soften(balance, axis, true, d, out_rest, &passes) || ss_norm3(d) < MAX_SLIP;
            is_along_axis = false;
        }
        if (!is_soft) {
            *out_rest = stiff;
            ss_copy3(d, start);
        }
    }
    out_rest->is_along_axis = is_along_axis;
    ss_add3(out_rest->p, balance->p_free, d);
    return passes;
}
