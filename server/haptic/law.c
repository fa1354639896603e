/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The local law: what the tissue answers between two results of the simulation.
 *
 * A result says: stepped to proxy p_k, moving at v_k, the contact at c with normal n gave force f,
 * tangent stiffness k_n, viscosity B, and the surface at rest bends by S. Until the next result
 *   F(p) = max(0, f - k (n.(p - p_k) - h) - B n.(pdot - v_k) + o),
 *   h = 1/2 D^T S D,   D = tangential part of x - p_k (|D| <= 5 mm),   n' ~ n - S D,
 * which is affine in p with the height taken at the pose used and the motion from there along n':
 *   n.(p - p_k) - h  ->  n.(x - p_k) - h + n'.(p - x),    pdot -> n'.(p - p-)/T.
 * (The normal n' is the gradient of the height that the force follows, so that the balance has a
 * potential and its matrix is symmetric.) Near but not touching: f = -k gap.
 *
 * k errs high, 1.15 k_n: the force is k x + (K - k) p_k with p_k old by one to two periods, a
 * delayed spring of K - k; K > k takes (K - k) x age from the damping, K < k adds to it.
 *
 * An update must not be felt: the offset o makes up for what the law changed at the last proxy and
 * decays within milliseconds. What per-contact offsets cannot carry (a normal that turned, a
 * contact that vanished) goes into a vector that decays alike. Rejected: blending two laws by
 * their forces, which softens both.
 *
 * hold and linear balance the proxy by the same law; only the force that they hand out is another.
 *
 * A grasp replaces the contacts by one tensor law without max(0, .): the reference force and point
 * are those of the moment of the grasp, later the model's. Letting go leaves the difference as an
 * offset that decays in 10 ms.
 */
#include "haptic/internal.h"

#include <string.h>

#include "rt/hash.h"
#include "rt/vec.h"

#define STIFFNESS_MIN    1.0  /* N/m */
#define STIFFNESS_MAX    1e5  /* N/m */
#define STIFFNESS_MARGIN 1.15 /* k / k_n */
#define SLOW_RESULTS                                                                               \
    0.060 /* s: with results this old k = k_n, the margin costs more than it gives */
#define PATCH_REACH  0.005 /* m, |D| */
#define RELEASE_TIME 0.010 /* s */
/* s, tau = h/4 within these. With 2 ms as the least, results at 300 to 1000 Hz let the inertia of a
 * stiff contact into the hand a few ticks late, and fast taps hand out 0.8 to 2.5 mJ; with 4 ms at
 * most 0.4 mJ. Static forces do not depend on it. */
#define OFFSET_TIME_MIN 0.004
#define OFFSET_TIME_MAX 0.008
/* s, tau while the force is at its limit. The proxy then goes where the tissue answers with the
 * limit, and the offsets' decay is the gain of that loop: with 4 ms it swings where the touched
 * tissue is heavy (a ventricle of soft tissue at 0.5 N: reactions of 0 to 14 times the limit), with
 * 30 ms in a lattice of springs, from 60 ms on in none of the models. Likewise while entering,
 * where tissue springs back against the tool: undelayed that steps a held ventricle by 6 % a tick.
 */
#define APART_TIME 0.060
/* s: in which it comes back to what it was, so that no offset is let go at once. At .5 N, in 3 ms a
 * kidney's viscosity is a step; in 20 ms the force on the way out of a liver is .18 N off its
 * reaction, in 5 ms .05 N. */
#define TOGETHER_TIME   0.005
#define NEGLIGIBLE      1e-6 /* N: a decayed offset ends here */
#define NEGLIGIBLE_TIME 1e-6 /* s: and here what slowed it */
/* s, B <= 3 ms x k_n. A fast simulation's step tangent is mostly the inertia of the touched tissue;
 * times the steps of a quantised position it is noise: at 1000 Hz 3.3 % buzz and 18 % continuity
 * with 10 ms, 2.4 and 9 % with 3 ms, and no more stability from either. */
#define VISCOSITY_TIME 0.003

void ss_law_clear(ss_law *law)
{
    memset(law, 0, sizeof *law);
    law->viscous = 1.0;
}

static double offset_time(const ss_law *law)
{
    return fmin(OFFSET_TIME_MAX, fmax(OFFSET_TIME_MIN, 0.25 * law->result_period));
}

static void decay3(double v[3], double factor)
{
    ss_scale3(v, v, factor);
    if (ss_norm3(v) < NEGLIGIBLE) {
        ss_set3(v, 0.0, 0.0, 0.0);
    }
}

/* Without a contact the residual is gone within a ramp: it smooths the change of a force that is no
 * more. */
static void let_go(ss_law *law)
{
    if (ss_law_active_count(law) > 0) {
        law->free_ticks = 0;
    } else if (law->free_ticks < SS_RAMP_TICKS) {
        const double left = SS_RAMP_TICKS - law->free_ticks;
        ss_scale3(law->residual, law->residual, (left - 1.0) / left);
        ++law->free_ticks;
    }
}

void ss_law_decay(ss_law *law, double period, double apart)
{
    const double usual = offset_time(law);
    law->slowness = fmax(apart * APART_TIME, law->slowness * exp(-period / TOGETHER_TIME));
    law->slowness = law->slowness > NEGLIGIBLE_TIME ? law->slowness : 0.0;
    law->is_apart = apart > 0.0;
    const double still = 1.0 - law->viscous;
    const double reaction = apart > still ? APART_TIME : TOGETHER_TIME;
    law->viscous = 1.0 - apart - (still - apart) * exp(-period / reaction);
    const double factor = exp(-period / usual);
    const double kept = exp(-period / fmax(usual, law->slowness));
    for (int32_t i = 0; i < law->count; ++i) {
        ss_law_contact *c = &law->contact[i];
        /* The value follows: it is what the law says now at the last proxy, and what an update must
         * keep. Kept with the old offset, results at every tick would never be let in. */
        const double lost = (1.0 - kept) * c->offset;
        c->value = c->value > 0.0 ? fmax(0.0, c->value - lost) : 0.0;
        c->offset -= lost;
    }
    if (law->held.is_held) {
        double lost[3];
        ss_scale3(lost, law->held.offset, 1.0 - kept);
        ss_sub3(law->held.offset, law->held.offset, lost);
        ss_sub3(law->held.value, law->held.value, lost);
    }
    decay3(law->residual, factor);
    let_go(law);
    decay3(law->released, exp(-period / RELEASE_TIME));
}

/* Height of the patch over its plane at x, and the bent normal. */
static double bend(const ss_law *law, const ss_law_contact *c, const double x[3],
                   double out_direction[3])
{
    double d[3], slope[3];
    ss_sub3(d, x, law->proxy);
    ss_madd3(d, d, -ss_dot3(d, c->normal), c->normal);
    const double reach = ss_norm3(d);
    if (reach > PATCH_REACH) {
        ss_scale3(d, d, PATCH_REACH / reach);
    }
    for (int r = 0; r < 3; ++r) {
        slope[r] = ss_dot3(c->curvature[r], d);
    }
    /* Beyond 45 degrees the parabola says nothing about the tissue. */
    const double steepness = ss_norm3(slope);
    if (steepness > 1.0) {
        ss_scale3(slope, slope, 1.0 / steepness);
    }
    ss_sub3(out_direction, c->normal, slope);
    if (ss_normalize3(out_direction) == 0.0) {
        ss_copy3(out_direction, c->normal);
    }
    return 0.5 * ss_dot3(d, slope);
}

/* F at `p` with velocity `pdot`, before max(0, .): writes direction. */
static double contact_force(const ss_law *law, ss_law_contact *c, const double x[3],
                            const double p[3], const double pdot[3])
{
    double from_k[3], from_x[3];
    const double height = bend(law, c, x, c->direction);
    ss_sub3(from_k, x, law->proxy);
    ss_sub3(from_x, p, x);
    const double rise = ss_dot3(c->normal, from_k) - height + ss_dot3(c->direction, from_x);
    const double speed = ss_dot3(c->direction, pdot) - ss_dot3(c->normal, law->velocity);
    return c->force - c->stiffness * rise - law->viscous * c->viscosity * speed + c->offset;
}

/* What hold and linear hand out in place of the law: bounded growth from the last two results. */
static double extrapolated_force(const ss_law *law, const ss_law_contact *c,
                                 const ss_haptic_config *config, int64_t tick)
{
    const double force = fmax(0.0, c->force);
    if (config->between_steps == SS_BETWEEN_HOLD) {
        return force;
    }
    const double age = fmin((double)(tick - law->tick) * config->period, 2.0 * law->result_period);
    return force + fmin(force, fmax(-force, c->rate * age));
}

void ss_law_force(const ss_law *law, double out[3])
{
    ss_add3(out, law->residual, law->released);
    for (int32_t i = 0; i < law->count; ++i) {
        ss_madd3(out, out, law->contact[i].value, law->contact[i].direction);
    }
    if (law->held.is_held) {
        ss_add3(out, out, law->held.value);
    }
}

void ss_law_settle(ss_law *law, const double direction[3])
{
    if (ss_norm3(direction) > 0.0) {
        ss_copy3(law->outward, direction);
        return;
    }
    ss_scale3(law->residual, law->outward, fmax(0.0, ss_dot3(law->residual, law->outward)));
}

void ss_law_extrapolate(const ss_law *law, const ss_haptic_config *config, int64_t tick,
                        double out[3])
{
    ss_copy3(out, law->released);
    for (int32_t i = 0; i < law->count; ++i) {
        const ss_law_contact *c = &law->contact[i];
        ss_madd3(out, out, extrapolated_force(law, c, config, tick), c->direction);
    }
}

void ss_law_torque(const ss_law *law, double out[3])
{
    ss_set3(out, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < law->count; ++i) {
        const ss_law_contact *c = &law->contact[i];
        double arm[3], force[3], torque[3];
        ss_sub3(arm, c->point, law->proxy);
        ss_scale3(force, c->direction, c->value);
        if (law->held.is_held && i == 0) {
            ss_add3(force, force, law->held.value);
        }
        ss_cross3(torque, arm, force);
        ss_add3(out, out, torque);
    }
}

int32_t ss_law_active_count(const ss_law *law)
{
    int32_t active = law->held.is_held ? (law->count > 0 ? law->count : 1) : 0;
    for (int32_t i = 0; !law->held.is_held && i < law->count; ++i) {
        active += law->contact[i].value > 0.0;
    }
    return active;
}

uint64_t ss_law_hash(const ss_law *law, uint64_t hash)
{
    const double *const vector[] = {law->held.value, law->held.offset, law->held.position,
                                    law->residual,   law->released,    law->outward};
    const double number[] = {law->slowness, law->viscous};
    const uint8_t flag[] = {law->held.is_held, (uint8_t)law->free_ticks};
    for (int32_t i = 0; i < law->count; ++i) {
        const double contact[2] = {law->contact[i].value, law->contact[i].offset};
        hash = ss_hash_bytes(hash, contact, sizeof contact);
    }
    for (size_t i = 0; i < sizeof vector / sizeof *vector; ++i) {
        hash = ss_hash_bytes(hash, vector[i], 3 * sizeof *vector[i]);
    }
    hash = ss_hash_bytes(hash, number, sizeof number);
    return ss_hash_bytes(hash, flag, sizeof flag);
}

/* Adds k n n^T + k_t (I - n n^T). */
static void add_contact(double m[3][3], const double n[3], double k, double k_t)
{
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            m[r][c] += (k - k_t) * n[r] * n[c] + (r == c ? k_t : 0.0);
        }
    }
}

void ss_law_stiffness(const ss_law *law, bool only_active, double out[3][3])
{
    memset(out, 0, 9 * sizeof(double));
    if (law->held.is_held) {
        memcpy(out, law->held.stiffness, 9 * sizeof(double));
        return;
    }
    for (int32_t i = 0; i < law->count; ++i) {
        const ss_law_contact *c = &law->contact[i];
        if (!only_active || c->value > 0.0) {
            add_contact(out, c->normal, c->stiffness, 0.0);
        }
    }
}

bool ss_law_surface(const ss_law *law, const double x[3], double out_normal[3], double out_point[3],
                    double *out_depth)
{
    int32_t deepest = -1;
    for (int32_t i = 0; i < law->count; ++i) {
        const ss_law_contact *c = &law->contact[i];
        double point[3], inward[3];
        const double yielded = c->force / c->model_stiffness;
        ss_madd3(point, law->proxy, law->depth > 0.0 ? fmax(yielded, law->depth) : yielded,
                 c->normal);
        ss_sub3(inward, point, x);
        const double depth = ss_dot3(c->normal, inward);
        if (deepest < 0 || depth > *out_depth) {
            deepest = i;
            *out_depth = depth;
            ss_copy3(out_point, point);
            ss_copy3(out_normal, c->normal);
        }
    }
    return deepest >= 0;
}

/* The old contact that a new one continues: the nearest that looks the same way; -1 none. */
static int32_t find_old(const ss_law *old, const ss_contact *now, uint32_t used)
{
    int32_t best = -1;
    double best_distance = INFINITY;
    for (int32_t i = 0; i < old->count; ++i) {
        double apart[3];
        ss_sub3(apart, old->contact[i].point, now->point);
        const double distance = ss_norm3(apart);
        if (!(used & (1U << i)) && ss_dot3(old->contact[i].normal, now->normal) > 0.5 &&
            distance < best_distance) {
            best = i;
            best_distance = distance;
        }
    }
    return best;
}

/* Parameters of one contact from the model's, guarded. */
static void take_contact(ss_law_contact *c, const ss_contact *from, double margin,
                         bool was_touching)
{
    memset(c, 0, sizeof *c);
    ss_copy3(c->normal, from->normal);
    ss_normalize3(c->normal);
    ss_copy3(c->direction, c->normal);
    ss_copy3(c->point, from->point);
    memcpy(c->curvature, from->curvature, sizeof c->curvature);
    c->model_stiffness = fmin(STIFFNESS_MAX, fmax(STIFFNESS_MIN, from->stiffness));
    c->stiffness = fmin(STIFFNESS_MAX, margin * c->model_stiffness);
    c->tangential = fmin(STIFFNESS_MAX, fmax(0.0, from->tangential));
    /* The viscosity of a first touch is the blow itself: as a law it would be a spike. */
    c->viscosity =
        was_touching ? fmin(VISCOSITY_TIME * c->model_stiffness, fmax(0.0, from->viscosity)) : 0.0;
    c->force = from->gap > 0.0 ? -c->stiffness * from->gap : fmax(0.0, from->force);
}

/* The tensors of a grasp from the contacts that carry it. */
static void held_tensors(ss_law *law, bool only_active)
{
    memset(law->held.stiffness, 0, sizeof law->held.stiffness);
    memset(law->held.viscosity, 0, sizeof law->held.viscosity);
    for (int32_t i = 0; i < law->count; ++i) {
        const ss_law_contact *c = &law->contact[i];
        if (!only_active || c->value > 0.0) {
            add_contact(law->held.stiffness, c->normal, c->stiffness, c->tangential);
            add_contact(law->held.viscosity, c->normal, c->viscosity, 0.0);
        }
    }
}

/* Force of the grasp's law at p, pdot. */
static void held_force(const ss_law_held *held, const double p[3], const double pdot[3],
                       double out[3])
{
    double d[3], w[3];
    ss_sub3(d, p, held->position);
    ss_sub3(w, pdot, held->velocity);
    for (int r = 0; r < 3; ++r) {
        out[r] = held->force[r] - ss_dot3(held->stiffness[r], d) - ss_dot3(held->viscosity[r], w) +
                 held->offset[r];
    }
}

void ss_law_hold(ss_law *law, const double p[3], const double pdot[3])
{
    ss_law_held *held = &law->held;
    ss_set3(held->force, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < law->count; ++i) {
        ss_madd3(held->force, held->force, law->contact[i].value, law->contact[i].direction);
    }
    held_tensors(law, true);
    for (int32_t i = 0; i < law->count; ++i) {
        law->contact[i].value = 0.0;
        law->contact[i].offset = 0.0;
    }
    ss_copy3(held->position, p);
    ss_copy3(held->velocity, pdot);
    ss_copy3(held->value, held->force);
    ss_set3(held->offset, 0.0, 0.0, 0.0);
    held->is_held = true;
}

void ss_law_release(ss_law *law, const double x[3], const double p[3], const double pdot[3])
{
    if (!law->held.is_held) {
        return;
    }
    ss_add3(law->released, law->released, law->held.value);
    law->held.is_held = false;
    ss_set3(law->held.value, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < law->count; ++i) {
        ss_law_contact *c = &law->contact[i];
        c->offset = 0.0;
        c->value = fmax(0.0, contact_force(law, c, x, p, pdot));
        ss_madd3(law->released, law->released, -c->value, c->direction);
    }
}

/* A result of a grasp: the model's whole reaction, with the step hidden in the offset. */
static void take_held(ss_law *law, const ss_local_model *result, const double p[3],
                      const double pdot[3])
{
    ss_law_held *held = &law->held;
    if (law->count > 0) {
        held_tensors(law, false);
    }
    ss_copy3(held->force, result->set.force);
    ss_copy3(held->position, result->proxy);
    ss_copy3(held->velocity, result->velocity);
    double now[3];
    ss_set3(held->offset, 0.0, 0.0, 0.0);
    held_force(held, p, pdot, now);
    ss_sub3(held->offset, held->value, now);
}

/* What contact `i` says now. At 0 and held back it goes by its own law, in which the offset has
 * decayed since: a hand at rest would else wait for ever for what results at every tick hold back
 * anew. While entering, where the hand is let in by and by, and at the limit, it stays held back.
 */
static double value_now(const ss_law *law, int32_t i, const double x[3], const double p[3],
                        const double pdot[3])
{
    ss_law_contact c = law->contact[i];
    const bool is_held_back = !(c.value > 0.0) && c.offset < 0.0 && !law->is_apart;
    return is_held_back ? fmax(0.0, contact_force(law, &c, x, p, pdot)) : c.value;
}

/* Offsets that keep every contact's force, and the residual for what they cannot keep. */
static void keep_force(ss_law *law, const ss_law *old, const int32_t source[], const double x[3],
                       const double p[3], const double pdot[3])
{
    uint32_t used = 0;
    for (int32_t i = 0; i < law->count; ++i) {
        ss_law_contact *c = &law->contact[i];
        const double before = source[i] >= 0 ? value_now(old, source[i], x, p, pdot) : 0.0;
        const double after = contact_force(law, c, x, p, pdot);
        /* Out of contact before: no more than to hold back what would appear at once. */
        c->offset = before > 0.0 ? before - after : -fmax(0.0, after);
        c->value = before;
        ss_madd3(law->residual, law->residual, -before, c->direction);
        if (source[i] >= 0) {
            used |= 1U << source[i];
            ss_madd3(law->residual, law->residual, before, old->contact[source[i]].direction);
        }
    }
    for (int32_t i = 0; i < old->count; ++i) {
        if (!(used & (1U << i))) {
            ss_madd3(law->residual, law->residual, old->contact[i].value,
                     old->contact[i].direction);
        }
    }
}

void ss_law_take(ss_law *law, const ss_local_model *result, const ss_haptic_config *config,
                 int64_t tick, const double x[3], const double p[3], const double pdot[3],
                 bool is_fresh)
{
    const ss_law old = *law;
    int32_t source[SS_MAX_CONTACTS];
    uint32_t used = 0;
    if (is_fresh) {
        ss_law_clear(law);
    }
    law->is_known = true;
    law->count = result->set.count;
    law->tick = result->tick;
    law->depth = result->set.depth;
    law->result_period = fmin(0.5, fmax(config->period, result->period));
    ss_copy3(law->proxy, result->proxy);
    ss_copy3(law->velocity, result->velocity);
    const double age = (double)(tick - result->tick) * config->period;
    const double margin = age + law->result_period > SLOW_RESULTS ? 1.0 : STIFFNESS_MARGIN;
    for (int32_t i = 0; i < law->count; ++i) {
        const ss_contact *from = &result->set.contact[i];
        source[i] = is_fresh ? -1 : find_old(&old, from, used);
        const ss_law_contact *before = source[i] >= 0 ? &old.contact[source[i]] : NULL;
        used |= before != NULL ? 1U << source[i] : 0U;
        take_contact(&law->contact[i], from, margin, before != NULL && before->force > 0.0);
        if (before != NULL && result->tick > old.tick) {
            law->contact[i].rate = (fmax(0.0, law->contact[i].force) - fmax(0.0, before->force)) /
                                   ((double)(result->tick - old.tick) * config->period);
        }
    }
    if (law->held.is_held) {
        if (result->set.is_held) {
            take_held(law, result, p, pdot);
        }
    } else if (!is_fresh) {
        keep_force(law, &old, source, x, p, pdot);
    }
}

void ss_law_rows(ss_law *law, double period, const double x[3], const double p[3],
                 ss_balance *balance)
{
    double pdot[3];
    ss_sub3(pdot, balance->p_free, p);
    ss_scale3(pdot, pdot, 1.0 / period);
    balance->is_held = law->held.is_held;
    balance->count = law->held.is_held ? 0 : law->count;
    for (int32_t i = 0; i < balance->count; ++i) {
        ss_law_contact *c = &law->contact[i];
        ss_balance_row *row = &balance->row[i];
        row->free_force = contact_force(law, c, x, balance->p_free, pdot);
        row->slope = c->stiffness + law->viscous * c->viscosity / period;
        ss_copy3(row->normal, c->direction);
    }
    if (law->held.is_held) {
        held_force(&law->held, balance->p_free, pdot, balance->held_force);
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) {
                balance->held_slope[r][c] =
                    law->held.stiffness[r][c] + law->held.viscosity[r][c] / period;
            }
        }
    }
}
