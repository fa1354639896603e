/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Friction between two results: a spring along the surface, within Coulomb's limit.
 *
 * A result says what friction f_k its anchors (contact/friction.c) exerted with the proxy at p_k.
 * Until the next one the proxy is held by
 *   f(p) = f_k - K_t (p - p_k) + o,   K_t = sum k_t (I - n_i n_i^T),
 * the sums over the contacts that push: p - p_k with the turn of a tool with extent. In steps,
 * p- the last proxy: f(p) = f(p-) - K_t (p - p-). That is the spring to an anchor
 * a = p + K_t^-1 f, which moves only where f is cut to Coulomb's limit: it slides. The same is then
 * taken off the offset o, which makes up for what an update changed and decays as the contacts'
 * offsets. Held to a limit with whatever F, what slides loses |f| |da| >= 0 and a falling limit
 * takes away what the spring has stored: this law never gives energy. Told forces and this law are
 * one force: an update replaces f_k, so that no motion is counted twice. What of f is beyond the
 * limit beside contacts that an update has turned goes to what decays beside them
 * (local_contact.c), and may give a hand something meanwhile (test_haptic_friction allows 1 mJ):
 * cut at once, a tip's normal that turned by 25 degrees turned the force by 6.
 *
 * Coulomb's limit of several contacts, n their mean normal: each has a disc of mu_i F_i in its own
 * plane, and the ellipsoid about the sum of the discs reaches
 *   L = sum mu_i F_i  along the surface,   L_n,  L_n^2 = L sum mu_i F_i (1 - (n_i.n)^2),  along n:
 * the flanks of a cone hold it in, or out. The model merges its samples into contacts whose forces
 * are less than the samples' own sizes; what it told was within its own limit, so both are at least
 * the told share: f_k's parts over sum F_k, times sum F_i.
 *
 * The balance (coupling.c) has it in all its equations. With M the spring's matrix, softened along
 * e where the force limit L_F asks for it, d = p - p_free and G(d) = sum F_i n_i, M d = G(d) + f,
 * |G(d) + f + R| <= L_F, sticks: f = f(p-) - K_t (p - p-) within L(d), L_n(d);   slides: cut to
 * these, L = L(d). What sticks is a spring like that of a grasp, and the balance solves it with the
 * contacts at once. What slides is f(L), cut from what would stick, and acts on the proxy whatever
 * it does; L - L(d) grows with L, since friction is a part of the force that leaves less of the
 * limit to the contacts, and its root is bracketed by 0 and what would stick: the Illinois rule
 * (Dowell and Jarratt 1971) needs one balance where the limit is not reached, 3 or 4 at it. e is
 * the direction of G alone: along that the proxy slips out. With f in it, a hand that turns round
 * would meet a proxy that lies on its other side by 2 mu times the slip.
 *
 * Where what would stick is more than L_F whatever the proxy gives up along e, it slides: as what
 * sticks with the proxy where it was along e, and with no more than L_F leaves room for
 * (bisection). A spring that softens all ways, as for contacts across e (coupling.c), would let it
 * go: the proxy was back where it had stuck, and the force turned by 45 degrees in a tick.
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
/* Of the sliding force: how near it comes to Coulomb's limit, and the balances that may take. */
#define SLIDE_TOLERANCE 1e-6
#define LEAN_MIN        1e-3
/* Of mu: what merged contacts exert beside the force that is left of them. */
#define MERGED_MOST 4.0
/* Of what is told along the surface: a round tool's rim leans in, and tells mu and 2 % more. */
#define ALONG_SHARE 0.95
enum { SLIDE_TRIES = 20 };

static bool has_coefficient(const ss_local_contact *local)
{
    bool is_any = false;
    for (int32_t i = 0; i < local->count; ++i) {
        is_any = is_any || local->contact[i].coefficient > 0.0;
    }
    return is_any;
}

/* What friction can do beside contacts that push. */
typedef struct friction_grip {
    double stiffness[3][3]; /* N/m, K_t */
    double normal[3];       /* n, unit; 0 without any */
    double limit;           /* N, L: along the surface, */
    double lean;            /* L_n / L */
    bool is_along_axis;     /* of the spring that the contacts alone soften */
} friction_grip;

/* N: Coulomb's, of contacts with `force`. */
static double coulomb(const ss_local_contact *local, const double force[])
{
    double limit = 0.0, sum = 0.0;
    for (int32_t i = 0; i < local->count; ++i) {
        limit += local->contact[i].coefficient * fmax(0.0, force[i]);
        sum += fmax(0.0, force[i]);
    }
    return fmax(limit, local->friction.share[0] * sum);
}

static void sum_contacts(const ss_local_contact *local, const double force[], friction_grip *out)
{
    double square = 0.0, sum = 0.0;
    *out = (friction_grip){.limit = coulomb(local, force)};
    for (int32_t i = 0; i < local->count; ++i) {
        ss_madd3(out->normal, out->normal, fmax(0.0, force[i]), local->contact[i].direction);
    }
    (void)ss_normalize3(out->normal);
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        if (!(force[i] > 0.0)) {
            continue;
        }
        const double *n = c->direction;
        double across[3];
        ss_cross3(across, n, out->normal);
        sum += force[i];
        square += c->coefficient * force[i] * ss_dot3(across, across);
        for (int row = 0; row < 3; ++row) {
            for (int col = 0; col < 3; ++col) {
                out->stiffness[row][col] +=
                    c->tangential * ((row == col ? 1.0 : 0.0) - n[row] * n[col]);
            }
        }
    }
    if (out->limit > 0.0) {
        const double leaning = fmax(sqrt(square * out->limit), local->friction.share[1] * sum);
        out->lean = leaning / out->limit;
    }
}

/* Holds `v` to `along` (N) along the surface and to `out` along the mean normal; true when it cut.
 */
static bool cut(const friction_grip *grip, double along, double out, double v[3])
{
    const double leaning = ss_dot3(grip->normal, v);
    const double over = leaning - fmin(out, fmax(-out, leaning));
    bool is_cut = fabs(over) > NEGLIGIBLE;
    ss_madd3(v, v, is_cut ? -over : 0.0, grip->normal);
    double flat[3];
    ss_madd3(flat, v, over - leaning, grip->normal);
    const double size = ss_norm3(flat);
    if (size > along) {
        ss_madd3(v, v, along / size - 1.0, flat);
        is_cut = true;
    }
    return is_cut;
}

/* v -= K_t d */
static void pull_back(double stiffness[3][3], const double d[3], double v[3])
{
    for (int k = 0; k < 3; ++k) {
        v[k] -= ss_dot3(stiffness[k], d);
    }
}

void ss_friction_decay(ss_local_friction *friction, double kept)
{
    double lost[3];
    ss_scale3(lost, friction->offset, 1.0 - kept);
    ss_sub3(friction->offset, friction->offset, lost);
    ss_sub3(friction->force, friction->force, lost);
    for (int k = 0; k < 2; ++k) {
        friction->share[k] =
            friction->share_told[k] + kept * (friction->share[k] - friction->share_told[k]);
    }
}

/* What the model exerted is within its own limit, beside contacts of `pressed` N. */
static void take_told(ss_local_contact *local, double pressed)
{
    ss_local_friction *friction = &local->friction;
    double normal[3] = {0.0, 0.0, 0.0}, most = 0.0, along[3];
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        ss_madd3(normal, normal, fmax(0.0, c->force), c->normal);
        most = fmax(most, MERGED_MOST * c->coefficient);
    }
    (void)ss_normalize3(normal);
    const double out = ss_dot3(friction->told, normal);
    ss_madd3(along, friction->told, -out, normal);
    const double size[2] = {ALONG_SHARE * ss_norm3(along), fabs(out)};
    for (int k = 0; k < 2; ++k) {
        friction->share_told[k] = pressed > 0.0 ? fmin(most, size[k] / pressed) : 0.0;
        friction->share[k] = fmax(friction->share[k], friction->share_told[k]);
    }
}

void ss_friction_take(ss_local_contact *local, const ss_contact_set *set, const double p[3])
{
    ss_local_friction *friction = &local->friction;
    double force[SS_MAX_CONTACTS], law[3], way[3], sum = 0.0;
    friction_grip grip;
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
    take_told(local, sum);
    sum_contacts(local, force, &grip);
    ss_add3(local->residual, local->residual, friction->force);
    (void)cut(&grip, grip.limit, grip.lean * grip.limit, friction->force);
    ss_sub3(local->residual, local->residual, friction->force);
    ss_sub3(way, p, local->proxy);
    ss_add3(way, way, friction->turned);
    ss_copy3(law, friction->told);
    pull_back(grip.stiffness, way, law);
    (void)cut(&grip, grip.limit, grip.lean * grip.limit, law);
    ss_sub3(friction->offset, friction->force, law);
}

/* f at p_free, and its slope K_t, as what holds the proxy in `balance`. */
static void hold(const friction_grip *grip, const ss_local_friction *friction, const double p[3],
                 const double turned[3], ss_balance *balance)
{
    double way[3];
    memcpy(balance->grasp_slope, grip->stiffness, sizeof balance->grasp_slope);
    ss_copy3(balance->grasp_force, friction->force);
    (void)cut(grip, INFINITY, grip->lean * grip->limit, balance->grasp_force);
    ss_sub3(way, balance->p_free, p);
    ss_add3(way, way, turned);
    pull_back(balance->grasp_slope, way, balance->grasp_force);
    balance->is_held = true;
}

/* The balance `from` with friction `force`, whatever the proxy does. */
static void push(const ss_balance *from, const double force[3], ss_balance *out)
{
    double d[3];
    *out = *from;
    ss_scale3(d, force, 1.0 / from->spring);
    ss_add3(out->p_free, out->p_free, d);
    ss_add3(out->other, out->other, force);
    for (int32_t i = 0; i < out->count; ++i) {
        out->row[i].free_force -= out->row[i].slope * ss_dot3(out->row[i].normal, d);
    }
}

/* Does friction ask for more than the force limit, whatever the proxy gives up along the axis? */
static bool is_beyond(const friction_grip *grip, const ss_rest *rest)
{
    return !rest->is_along_axis && grip->is_along_axis;
}

/* What would stick with the proxy where it was, at `p`, along the axis of `with`. */
static void stick_beside(const double p[3], ss_balance *with, ss_rest *rest, double out_stuck[3])
{
    double way[3];
    with->limit = INFINITY;
    (void)ss_coupling_balance(with, rest);
    ss_sub3(way, rest->p, p);
    ss_madd3(way, rest->p, -ss_dot3(way, with->axis), with->axis);
    ss_sub3(way, way, with->p_free);
    ss_copy3(out_stuck, with->grasp_force);
    pull_back(with->grasp_slope, way, out_stuck);
}

/* The balance `from` with what is left of `stuck` within the limit `now`. */
static void try_limit(const friction_grip *grip, const ss_balance *from, const double stuck[3],
                      double now, ss_balance *out, ss_rest *rest, double out_force[3])
{
    ss_copy3(out_force, stuck);
    (void)cut(grip, fmin(now, from->limit), grip->lean * now, out_force);
    push(from, out_force, out);
    (void)ss_coupling_balance(out, rest);
}

/* Slides against `stuck`, from what would stick: held to that limit which is Coulomb's of its own
 * balance, from what it is without friction. */
static void slide(const ss_local_contact *local, const friction_grip *grip, const ss_balance *from,
                  const double stuck[3], ss_balance *out, ss_rest *rest, double out_force[3])
{
    const double first = grip->limit;
    const double out_of = fabs(ss_dot3(stuck, grip->normal)) / fmax(LEAN_MIN, grip->lean);
    double low = 0.0, below = -first, high = fmax(ss_norm3(stuck), out_of);
    double above = high - first, now = fmin(first, high);
    int side = 0;
    for (int i = 0; i < SLIDE_TRIES; ++i) {
        try_limit(grip, from, stuck, now, out, rest, out_force);
        const double over = is_beyond(grip, rest) ? INFINITY : now - coulomb(local, rest->force);
        if (fabs(over) <= SLIDE_TOLERANCE * now || (now >= high && over <= 0.0)) {
            break;
        }
        if (over > 0.0) {
            high = now;
            above = over;
            below *= side > 0 ? 0.5 : 1.0;
            side = 1;
        } else {
            low = now;
            below = over;
            above *= side < 0 ? 0.5 : 1.0;
            side = -1;
        }
        if (above < INFINITY) {
            now = above > below ? (low * above - high * below) / (above - below) : low;
        } else {
            now = 0.5 * (low + high);
        }
    }
    if (is_beyond(grip, rest)) {
        try_limit(grip, from, stuck, low, out, rest, out_force);
    }
}

/* What of the hand's way along the surface the proxy goes, for a coupling of `spring`. */
static void follow_sliding(ss_local_contact *local, const ss_rest *rest, double spring,
                           double period)
{
    ss_local_friction *friction = &local->friction;
    friction_grip grip;
    sum_contacts(local, rest->force, &grip);
    const double along = 0.5 * (grip.stiffness[0][0] + grip.stiffness[1][1] + grip.stiffness[2][2]);
    const double share = friction->is_sliding ? 1.0 : spring / (spring + along);
    friction->held += (1.0 - exp(-period / FOLLOW_TIME)) * (1.0 - share - friction->held);
}

void ss_friction_balance(ss_local_contact *local, const double p[3], double spring, double period,
                         ss_balance *balance, ss_rest *rest)
{
    ss_local_friction *friction = &local->friction;
    double turned[3], since[3], stuck[3];
    ss_balance with = *balance;
    friction_grip grip;
    sum_contacts(local, rest->force, &grip);
    grip.is_along_axis = rest->is_along_axis;
    ss_cross3(turned, local->turn, friction->arm);
    ss_sub3(since, turned, friction->turned);
    ss_copy3(friction->turned, turned);
    if (!(ss_norm3(with.axis) > 0.0)) {
        ss_sub3(with.axis, rest->p, with.p_free);
        (void)ss_normalize3(with.axis);
    }
    ss_copy3(balance->axis, with.axis);
    hold(&grip, friction, p, since, &with);
    (void)ss_coupling_balance(&with, rest);
    ss_copy3(stuck, rest->grasp);
    ss_copy3(friction->force, stuck);
    const double limit = coulomb(local, rest->force);
    friction->is_sliding = cut(&grip, limit, grip.lean * limit, friction->force);
    if (is_beyond(&grip, rest)) {
        friction->is_sliding = true;
        stick_beside(p, &with, rest, stuck);
    }
    if (!friction->is_sliding) {
        push(balance, stuck, &with);
        ss_set3(rest->grasp, 0.0, 0.0, 0.0);
    } else {
        const double size = fmax(NEGLIGIBLE, ss_norm3(stuck));
        slide(local, &grip, balance, stuck, &with, rest, friction->force);
        ss_scale3(friction->offset, friction->offset, ss_norm3(friction->force) / size);
    }
    *balance = with;
    follow_sliding(local, rest, spring, period);
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
