/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Friction between two results: a spring along the surface, within Coulomb's limit.
 *
 * A result says what friction f_k its anchors (contact/friction.c) exerted with the proxy at p_k.
 * Until the next one the proxy is held by
 *   f(p) = f_k - K_t (p - p_k) + o,   K_t = sum k_t (I - n n^T),   |f| <= L = sum mu_i F_i(p),
 * the sums over the contacts that push: p - p_k with the turn of a tool with extent. In steps,
 * p- the last proxy: f(p) = f(p-) - K_t (p - p-). That is the spring to an anchor
 * a = p + K_t^-1 f, which moves only where f is cut to L: it slides. The same is then taken off
 * the offset o, which makes up for what an update changed and decays as the contacts' offsets.
 * Held to L with whatever F, what slides loses |f| |da| >= 0 and a falling L takes away what the
 * spring has stored: it never gives energy. Told forces and this law are one force: an update
 * replaces f_k, so that no motion is counted twice.
 *
 * The balance (coupling.c) with the friction: the spring between hand and proxy is K on all sides,
 * so that with one contact the way along the surface, d, has nothing to do with that across it,
 *   (K I + K_t) d = f(p_0),   f = K d,   cut to L,
 * p_0 where the proxy rests without friction. f then pushes the proxy as what acts beside the
 * contacts does, and the balance is solved once more. With several contacts the second balance
 * changes F, and what is above mu F then is cut.
 *
 * Rejected: an anchor for each contact (the contacts of one tool are parts of one touch, moved by
 * one proxy; eight cones have no potential, and no bound on the passes); friction from the
 * proxy's velocity (creeps); the model's own friction held until the next result (a hand that stops
 * is pushed back for a step by what it felt while it slid).
 */
#include "haptic/internal.h"

#include <string.h>

#include "rt/vec.h"

#define NEGLIGIBLE 1e-9 /* N */
/* s: in which the share of its way that a tool goes follows when it begins or ends to slide. */
#define FOLLOW_TIME 0.010

static bool has_coefficient(const ss_local_contact *local)
{
    bool is_any = false;
    for (int32_t i = 0; i < local->count; ++i) {
        is_any = is_any || local->contact[i].coefficient > 0.0;
    }
    return is_any;
}

/* L, K_t and the mean normal, which has a length below 1 where contacts look different ways, of
 * contacts with `force`. */
static double sum_contacts(const ss_local_contact *local, const double force[],
                           double out_stiffness[3][3], double out_normal[3])
{
    double limit = 0.0, sum = 0.0;
    memset(out_stiffness, 0, 9 * sizeof(double));
    ss_set3(out_normal, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        if (!(force[i] > 0.0)) {
            continue;
        }
        const double *n = c->direction;
        limit += c->coefficient * force[i];
        sum += force[i];
        ss_madd3(out_normal, out_normal, force[i], n);
        for (int row = 0; row < 3; ++row) {
            for (int col = 0; col < 3; ++col) {
                out_stiffness[row][col] +=
                    c->tangential * ((row == col ? 1.0 : 0.0) - n[row] * n[col]);
            }
        }
    }
    ss_scale3(out_normal, out_normal, sum > 0.0 ? 1.0 / sum : 0.0);
    return limit;
}

/* v -= K_t d */
static void pull_back(double stiffness[3][3], const double d[3], double v[3])
{
    for (int k = 0; k < 3; ++k) {
        v[k] -= ss_dot3(stiffness[k], d);
    }
}

void ss_friction_cut(ss_local_friction *friction, double limit)
{
    const double size = ss_norm3(friction->force);
    friction->is_sliding = size > limit;
    if (friction->is_sliding) {
        const double share = limit > NEGLIGIBLE ? limit / size : 0.0;
        ss_scale3(friction->force, friction->force, share);
        ss_scale3(friction->offset, friction->offset, share);
    }
}

void ss_friction_decay(ss_local_friction *friction, double kept)
{
    double lost[3];
    ss_scale3(lost, friction->offset, 1.0 - kept);
    ss_sub3(friction->offset, friction->offset, lost);
    ss_sub3(friction->force, friction->force, lost);
}

void ss_friction_take(ss_local_contact *local, const ss_contact_set *set, const double p[3])
{
    ss_local_friction *friction = &local->friction;
    double force[SS_MAX_CONTACTS], stiffness[3][3], normal[3], law[3], way[3];
    double sum = 0.0;
    friction->is_used = has_coefficient(local) || ss_norm3(friction->force) > 0.0;
    if (!friction->is_used) {
        return;
    }
    ss_copy3(friction->told, set->friction);
    ss_copy3(friction->torque, set->friction_torque);
    ss_set3(friction->arm, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        double arm[3];
        force[i] = c->last_force;
        ss_sub3(arm, c->point, local->proxy);
        const double weight = fmax(0.0, c->force);
        ss_madd3(friction->arm, friction->arm, weight, arm);
        sum += weight;
    }
    ss_scale3(friction->arm, friction->arm, sum > 0.0 ? 1.0 / sum : 0.0);
    ss_cross3(friction->turned, local->turn, friction->arm);
    const double limit = sum_contacts(local, force, stiffness, normal);
    ss_sub3(way, p, local->proxy);
    ss_add3(way, way, friction->turned);
    ss_copy3(law, friction->told);
    pull_back(stiffness, way, law);
    (void)ss_clamp_norm3(law, limit);
    ss_sub3(friction->offset, friction->force, law);
}

void ss_friction_balance(ss_local_contact *local, const double p[3], const ss_rest *without,
                         ss_balance *balance)
{
    ss_local_friction *friction = &local->friction;
    double stiffness[3][3], a[3][3], normal[3], way[3], turned[3], d[3];
    const double limit = sum_contacts(local, without->force, stiffness, normal);
    ss_cross3(turned, local->turn, friction->arm);
    ss_sub3(way, without->p, p);
    ss_add3(way, way, turned);
    ss_sub3(way, way, friction->turned);
    ss_copy3(friction->turned, turned);
    pull_back(stiffness, way, friction->force);
    ss_madd3(friction->force, friction->force, -ss_dot3(normal, friction->force), normal);
    memcpy(a, stiffness, sizeof a);
    for (int k = 0; k < 3; ++k) {
        a[k][k] += balance->spring;
    }
    ss_cholesky_solve3(a, friction->force, d);
    ss_scale3(friction->force, d, balance->spring);
    ss_friction_cut(friction, limit);
    ss_scale3(d, friction->force, 1.0 / balance->spring);
    ss_add3(balance->p_free, balance->p_free, d);
    ss_add3(balance->other, balance->other, friction->force);
    for (int32_t i = 0; i < balance->count; ++i) {
        ss_balance_row *row = &balance->row[i];
        row->free_force -= row->slope * ss_dot3(row->normal, d);
    }
}

void ss_friction_settle(ss_local_contact *local, const ss_rest *rest, double spring, double period,
                        ss_balance *balance)
{
    ss_local_friction *friction = &local->friction;
    double stiffness[3][3], normal[3], over[3];
    const bool was_sliding = friction->is_sliding;
    const double limit = sum_contacts(local, rest->force, stiffness, normal);
    ss_copy3(over, friction->force);
    ss_friction_cut(friction, limit);
    ss_sub3(over, over, friction->force);
    ss_sub3(balance->other, balance->other, over);
    friction->is_sliding = friction->is_sliding || was_sliding;
    /* What of the hand's way along the surface the proxy goes. */
    const double along = 0.5 * (stiffness[0][0] + stiffness[1][1] + stiffness[2][2]);
    const double share = friction->is_sliding ? 1.0 : spring / (spring + along);
    friction->held += (1.0 - exp(-period / FOLLOW_TIME)) * (1.0 - share - friction->held);
}

void ss_friction_torque(const ss_local_contact *local, double out[3])
{
    const ss_local_friction *friction = &local->friction;
    const double told = ss_norm3(friction->told);
    const double share = told > 0.0 ? fmin(1.0, ss_norm3(friction->force) / told) : 0.0;
    double since[3], torque[3];
    ss_madd3(since, friction->force, -share, friction->told);
    ss_cross3(torque, friction->arm, since);
    ss_madd3(out, out, share, friction->torque);
    ss_add3(out, out, torque);
}
