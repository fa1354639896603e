/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The local contact model: what the tissue answers between two results of the simulation.
 *
 * A result says: stepped to proxy p_k, moving at v_k, the contact at c with normal n gave force f,
 * tangent stiffness k_n, viscosity B, and the surface at rest bends by S. Until the next result
 *   F(p) = max(0, f - k (n.(p - p_k) - s) - B n.(pdot - v_k) + o),
 *   s = 1/2 D^T S D,   D = tangential part of x - p_k (|D| <= 5 mm),   n' ~ n - S D,
 * which is affine in p with the height s taken at the pose used and the motion from there along n':
 *   n.(p - p_k) - s  ->  n.(x - p_k) - s + n'.(p - x),    pdot -> n'.(p - p-)/T.
 * (The normal n' is the gradient of the height that the force follows, so that the balance has a
 * potential and its matrix is symmetric.) Near but not touching: f = -k gap. A tool with extent
 * that has turned by theta since is, at the contact, n'.(theta x (c - p_k)) further out; the sum of
 * (c - p_k) x F n' is its torque.
 *
 * k errs high, 1.15 k_n: the force is k x + (K - k) p_k with p_k old by one to two periods, a
 * delayed spring of K - k; K > k takes (K - k) x age from the damping, K < k adds to it. What is
 * near errs higher, for a touch that is no blow (margin_of).
 *
 * An update must not be felt: the offset o makes up for what the local contact model changed at the
 * last proxy and decays within milliseconds. What per-contact offsets cannot carry (a normal that
 * turned, a contact that vanished) goes into a vector that decays in the same way, and so does what
 * it changed of the torque. Rejected: blending two laws by their forces, which softens both.
 *
 * What pushes the tool beside its contacts comes to hand and proxy as it is, smoothed like an
 * update, and ends with them. Rejected: contacts turned to the whole force (where the tissue comes
 * off the tool that lies across the surface, and a law along it is blind to the way in: a kidney
 * whose limit was lowered threw the proxy to and fro between reactions of 1 and 15 N); handing it
 * to the hand alone (the coupling's stretch then turns with the contact and works for nobody).
 *
 * hold and linear balance the proxy by the same law; only the force that they hand out is another.
 *
 * A grasp replaces the contacts by one tensor law without max(0, .): the reference force and point
 * are those of the moment of the grasp, later the model's. It stays until the model holds no more,
 * which is a while after the button (haptic.c). What was felt then, W, fades out as what the law
 * says from then on, F, fades in:
 *   (1 - b) F + b W,   b = e^(-t / 10 ms),
 * which is no larger than the larger of the two, whatever becomes of F. Rejected: W - F as an
 * offset that decays (it points into the tissue where F changes meanwhile), and contacts that begin
 * while the model still holds (what the springs leave of its reaction is not along their normals: a
 * cone dragged aside in a liver and let go at 0.95 N was felt with 3.2 N).
 */
#include "haptic/internal.h"

#include <string.h>

#include "rt/hash.h"
#include "rt/vec.h"

#define STIFFNESS_MIN    1e-6 /* N/m: a body of metres and pascals has less than 1 */
#define STIFFNESS_MAX    1e5  /* N/m */
#define STIFFNESS_MARGIN 1.15 /* k / k_n */
#define COEFFICIENT_MAX  10.0 /* mu, as a scene may have it */
/* k / k_n of what is near: a touch meets the tissue's inertia, which stiffness at rest has not. A
 * tool that would go TOUCH_WAY (m) until a result answers counts half of that: the law of a blow is
 * too stiff anyway when the answer comes. */
#define TOUCH_MARGIN 1.33
#define TOUCH_WAY    0.004
#define SLOW_RESULTS                                                                               \
    0.060 /* s: with results this old k = k_n, the margin costs more than it gives */
/* s: with results as fast as this what a grasp draws at is steadied too, not only what presses. At
 * 100 Hz a kidney that a cone holds still moved by .110 of 5.4 N in 1.5 s with it, .048 without. */
#define SWIFT_RESULTS 0.006
#define PATCH_REACH   0.005 /* m, |D| */
#define ENDING_TIME   0.004 /* s */
/* s, B <= 3 ms x k_n. A fast simulation's step tangent is mostly the inertia of the touched tissue;
 * times the steps of a quantised position it is noise: at 1000 Hz 3.3 % buzz and 18 % continuity
 * (metrics of bench/latency) with 10 ms, 2.4 and 9 % with 3 ms, and no more stability from either.
 */
#define VISCOSITY_TIME 0.003
/* s: and of what steadies the loop, which is wanted where the coupling is soft. */
#define STEADY_TIME 0.020

void ss_local_contact_clear(ss_local_contact *local)
{
    memset(local, 0, sizeof *local);
    local->viscosity_fraction = 1.0;
    local->offset_time = SS_OFFSET_TIME_MIN;
}

/* Height of the patch over its plane at x, and the bent normal. */
static double bend(const ss_local_contact *local, const ss_local_contact_point *c,
                   const double x[3], double out_direction[3])
{
    double d[3], slope[3];
    ss_sub3(d, x, local->proxy);
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
static double contact_force(const ss_local_contact *local, ss_local_contact_point *c,
                            const double x[3], const double p[3], const double pdot[3])
{
    double from_k[3], from_x[3], arm[3], turned[3];
    const double height = bend(local, c, x, c->direction);
    ss_sub3(from_k, x, local->proxy);
    ss_sub3(from_x, p, x);
    ss_sub3(arm, c->point, local->proxy);
    ss_cross3(turned, local->turn, arm);
    ss_add3(from_x, from_x, turned);
    const double rise = ss_dot3(c->normal, from_k) - height + ss_dot3(c->direction, from_x);
    const double speed = ss_dot3(c->direction, pdot) - ss_dot3(c->normal, local->velocity);
    return c->force - c->stiffness * rise - local->viscosity_fraction * c->viscosity * speed +
           c->offset;
}

/* What hold and linear hand out in place of the local contact model: bounded growth from the last
 * two results. */
static double extrapolated_force(const ss_local_contact *local, const ss_local_contact_point *c,
                                 const ss_haptic_config *config, int64_t tick)
{
    const double force = fmax(0.0, c->force);
    if (config->between_steps == SS_BETWEEN_HOLD) {
        return force;
    }
    const double age =
        fmin((double)(tick - local->tick) * config->period, 2.0 * local->result_period);
    return force + fmin(force, fmax(-force, c->rate * age));
}

/* Of what the law says and what a grasp let go left, what is felt. */
static void blend_released(const ss_local_contact *local, double inout_force[3])
{
    const ss_local_contact_released *released = &local->released;
    ss_scale3(inout_force, inout_force, 1.0 - released->share);
    ss_madd3(inout_force, inout_force, released->share, released->force);
}

void ss_local_contact_felt(const ss_local_contact *local, double out[3])
{
    ss_local_contact_force(local, out);
    blend_released(local, out);
}

void ss_local_contact_force(const ss_local_contact *local, double out[3])
{
    ss_madd3(out, local->residual, local->other.share, local->other.force);
    if (local->friction.is_used) {
        ss_add3(out, out, local->friction.force);
    }
    for (int32_t i = 0; i < local->count; ++i) {
        ss_madd3(out, out, local->contact[i].last_force, local->contact[i].direction);
    }
    if (local->grasp.is_held) {
        ss_add3(out, out, local->grasp.last_force);
    }
}

void ss_local_contact_clip_residual(ss_local_contact *local, const double direction[3], double size)
{
    if (ss_norm3(direction) > 0.0) {
        ss_copy3(local->outward, direction);
        if (!local->grasp.is_held) {
            const double inward = -ss_dot3(local->residual, direction) - size;
            ss_madd3(local->residual, local->residual, fmax(0.0, inward), direction);
        }
        return;
    }
    ss_scale3(local->residual, local->outward, fmax(0.0, ss_dot3(local->residual, local->outward)));
    local->other.share = 0.0;
}

void ss_local_contact_extrapolate(const ss_local_contact *local, const ss_haptic_config *config,
                                  int64_t tick, double out[3])
{
    ss_scale3(out, local->other.force, local->other.share);
    if (local->friction.is_used) {
        ss_add3(out, out, local->friction.force);
    }
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        ss_madd3(out, out, extrapolated_force(local, c, config, tick), c->direction);
    }
    blend_released(local, out);
}

int32_t ss_local_contact_active_count(const ss_local_contact *local)
{
    int32_t active = local->grasp.is_held ? (local->count > 0 ? local->count : 1) : 0;
    for (int32_t i = 0; !local->grasp.is_held && i < local->count; ++i) {
        active += local->contact[i].last_force > 0.0;
    }
    return active;
}

uint64_t ss_local_contact_hash(const ss_local_contact *local, uint64_t hash)
{
    const double *const vector[] = {local->grasp.last_force, local->grasp.offset,
                                    local->grasp.position,   local->residual,
                                    local->released.force,   local->outward};
    const double number[] = {local->min_offset_time, local->viscosity_fraction};
    const uint8_t flag[] = {local->grasp.is_held, (uint8_t)local->free_ticks};
    const ss_local_contact_other *other = &local->other;
    if (local->released.share > 0.0) {
        hash = ss_hash_bytes(hash, &local->released.share, sizeof local->released.share);
        hash = ss_hash_bytes(hash, local->released.torque, sizeof local->released.torque);
    }
    if (ss_norm3(other->force) > 0.0) {
        hash = ss_hash_bytes(hash, other->force, sizeof other->force);
    }
    if (ss_norm3(local->residual_torque) > 0.0) {
        hash = ss_hash_bytes(hash, local->residual_torque, sizeof local->residual_torque);
    }
    if (local->friction.is_used) {
        const ss_local_friction *friction = &local->friction;
        hash = ss_hash_bytes(hash, friction->force, sizeof friction->force);
        hash = ss_hash_bytes(hash, friction->offset, sizeof friction->offset);
        hash = ss_hash_bytes(hash, &friction->held, sizeof friction->held);
        hash = ss_hash_bytes(hash, friction->share, sizeof friction->share);
    }
    if (local->grasp.is_held) {
        const uint8_t ending[] = {local->grasp.is_ending, local->grasp.is_answered};
        hash = ss_hash_bytes(hash, ending, sizeof ending);
        hash = ss_hash_bytes(hash, local->grasp.drift, sizeof local->grasp.drift);
    }
    for (int32_t i = 0; i < local->count; ++i) {
        const double contact[] = {local->contact[i].last_force, local->contact[i].offset,
                                  local->contact[i].drift};
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

void ss_local_contact_stiffness(const ss_local_contact *local, bool only_active, double out[3][3])
{
    memset(out, 0, 9 * sizeof(double));
    if (local->grasp.is_held) {
        memcpy(out, local->grasp.stiffness, 9 * sizeof(double));
        return;
    }
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        if (!only_active || c->last_force > 0.0) {
            /* Erring high at every rate, as the law but for slow results: else a press behind a
             * soft coupling is held with 3 % more at 30 Hz. */
            const double high = fmin(STIFFNESS_MAX, STIFFNESS_MARGIN * c->model_stiffness);
            add_contact(out, c->normal, high, 0.0);
        }
    }
}

double ss_local_contact_stiffness_along(const ss_local_contact *local, const double n[3])
{
    double tissue[3][3];
    double k = 0.0;
    ss_local_contact_stiffness(local, true, tissue);
    for (int r = 0; r < 3; ++r) {
        k += n[r] * ss_dot3(tissue[r], n);
    }
    return k;
}

void ss_local_contact_tangent(const ss_local_contact *local, double seconds, double out[3][3])
{
    /* Within a result the law errs high; the next one takes that back. */
    const double within = local->count > 0 ? fmax(0.0, 1.0 - seconds / local->result_period) : 0.0;
    memset(out, 0, 9 * sizeof(double));
    for (int r = 0; r < 3 && local->grasp.is_held; ++r) {
        for (int c = 0; c < 3; ++c) {
            const double own = local->grasp.tangent[r][c];
            out[r][c] = own + within * (local->grasp.stiffness[r][c] - own);
        }
    }
    for (int32_t i = 0; i < local->count && !local->grasp.is_held; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        if (c->last_force > 0.0) {
            const double high = c->stiffness - c->model_stiffness;
            add_contact(out, c->direction, c->model_stiffness + within * high, 0.0);
        }
    }
}

bool ss_local_contact_surface(const ss_local_contact *local, const double x[3],
                              double out_normal[3], double out_point[3], double *out_depth)
{
    int32_t deepest = -1;
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        double point[3], inward[3];
        const double yielded = c->force / c->model_stiffness;
        ss_madd3(point, local->proxy, local->depth > 0.0 ? fmax(yielded, local->depth) : yielded,
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

/* Of the contacts that push together; where none does yet, of the one that leaves the least. */
double ss_local_contact_room(const ss_local_contact *local, const double p[3], double limit,
                             double out_outward[3])
{
    double force[3] = {0.0, 0.0, 0.0}, room = INFINITY;
    ss_set3(out_outward, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < local->count && !local->grasp.is_held; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        double way[3];
        ss_sub3(way, p, local->proxy);
        const double law_force = c->force - c->stiffness * ss_dot3(c->normal, way);
        const double left = fmax(0.0, (limit - law_force) / c->stiffness);
        ss_madd3(force, force, c->last_force, c->direction);
        if (left < room) {
            room = left;
            ss_copy3(out_outward, c->normal);
        }
    }
    const double size = ss_norm3(force);
    if (size > 0.0) {
        ss_scale3(out_outward, force, 1.0 / size);
        room = fmax(0.0, limit - size) / ss_local_contact_stiffness_along(local, out_outward);
    }
    return room;
}

/* Does one of the set belong to that part of the tool? */
static bool has_station(const ss_contact_set *set, int32_t station)
{
    bool is_there = false;
    for (int32_t i = 0; i < set->count; ++i) {
        is_there = is_there || set->contact[i].station == station;
    }
    return is_there;
}

/* The old contact that contact `k` of the set continues, -1 none: that of the same part of the
 * tool. Else it is a touch that goes over to another part: of the old ones whose part the set has
 * not, the nearest. Both look the same way. By nearness alone a part that begins to touch took the
 * force of its neighbour, that of the next one, and the last began anew: as the ends of a capsule
 * that tilts came under and out, 3 to 5 % of the force stepped. */
static int32_t find_old(const ss_local_contact *old, const ss_contact_set *set, int32_t k,
                        uint32_t used)
{
    const ss_contact *now = &set->contact[k];
    int32_t best = -1;
    double best_distance = INFINITY;
    for (int32_t i = 0; i < old->count; ++i) {
        const bool is_same = old->contact[i].station == now->station;
        double apart[3];
        ss_sub3(apart, old->contact[i].point, now->point);
        const double distance = is_same ? 0.0 : ss_norm3(apart);
        const bool is_open = is_same || !has_station(set, old->contact[i].station);
        if (is_open && !(used & (1U << i)) && ss_dot3(old->contact[i].normal, now->normal) > 0.5 &&
            distance < best_distance) {
            best = i;
            best_distance = distance;
        }
    }
    return best;
}

/* N s/m: what keeps the loop of proxy and simulation still, in a grasp on all sides. A step of the
 * proxy changes the reaction by the swift stiffness S one result late, and the law by k + B/h at
 * once; changes die out from result to result where S - (k + B/h) < K_c + k + B/h, and at once
 * where k + B/h is all that the coupling leaves of S. A soft tool on soft tissue, with a stiff
 * coupling, needs none. */
static double steadying(const ss_contact *from, double spring, double period)
{
    const double wanted = period * (from->swift - spring - from->stiffness);
    return fmax(0.0, fmin(wanted, STEADY_TIME * from->stiffness));
}

/* k / k_n of a contact; `margin` of one that touches. */
static double margin_of(const ss_local_contact *local, const ss_contact *from, double margin)
{
    if (!(from->gap > 0.0)) {
        return margin;
    }
    const double way = 2.0 * local->result_period * ss_dot3(local->velocity, from->normal);
    const double square = way * way / (TOUCH_WAY * TOUCH_WAY);
    return margin + fmax(0.0, TOUCH_MARGIN - margin) / (1.0 + square * square);
}

/* Parameters of one contact from the model's, guarded; `spring` and `period` as steadying takes
 * them. */
static void take_contact(ss_local_contact_point *c, const ss_contact *from, double margin,
                         bool was_touching, double spring, double period)
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
    /* At first touch the reported viscosity is mostly impact; used as a coefficient it would give a
     * force spike. */
    const double viscosity = fmin(VISCOSITY_TIME * c->model_stiffness, fmax(0.0, from->viscosity));
    c->viscosity = was_touching ? fmax(viscosity, steadying(from, spring, period)) : 0.0;
    c->coefficient = fmin(COEFFICIENT_MAX, fmax(0.0, from->coefficient));
    c->station = from->station;
    c->force = from->gap > 0.0 ? -c->stiffness * from->gap : fmax(0.0, from->force);
}

/* The tensors of a grasp from the contacts that carry it. */
static void set_grasp_tensors(ss_local_contact *local, bool only_active)
{
    memset(local->grasp.stiffness, 0, sizeof local->grasp.stiffness);
    memset(local->grasp.viscosity, 0, sizeof local->grasp.viscosity);
    memset(local->grasp.tangent, 0, sizeof local->grasp.tangent);
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        if (!only_active || c->last_force > 0.0) {
            add_contact(local->grasp.stiffness, c->normal, c->stiffness, c->tangential);
            add_contact(local->grasp.viscosity, c->normal, c->viscosity, c->viscosity);
            add_contact(local->grasp.tangent, c->normal, c->model_stiffness, c->tangential);
        }
    }
}

/* Force of the grasp's law at p, pdot. */
static void force_of_grasp(const ss_local_contact_grasp *grasp, const double p[3],
                           const double pdot[3], double out[3])
{
    double d[3], w[3];
    ss_sub3(d, p, grasp->position);
    ss_sub3(w, pdot, grasp->velocity);
    for (int r = 0; r < 3; ++r) {
        out[r] = grasp->force[r] - ss_dot3(grasp->stiffness[r], d) -
                 ss_dot3(grasp->viscosity[r], w) + grasp->offset[r];
    }
}

void ss_local_contact_hold(ss_local_contact *local, const double p[3], const double pdot[3])
{
    ss_local_contact_grasp *grasp = &local->grasp;
    ss_local_contact_torque(local, grasp->torque);
    ss_set3(local->residual_torque, 0.0, 0.0, 0.0);
    ss_scale3(grasp->force, local->other.force, local->other.share);
    if (local->friction.is_used) {
        ss_add3(grasp->force, grasp->force, local->friction.force);
    }
    memset(&local->other, 0, sizeof local->other);
    memset(&local->friction, 0, sizeof local->friction);
    for (int32_t i = 0; i < local->count; ++i) {
        ss_madd3(grasp->force, grasp->force, local->contact[i].last_force,
                 local->contact[i].direction);
    }
    set_grasp_tensors(local, true);
    for (int32_t i = 0; i < local->count; ++i) {
        local->contact[i].last_force = 0.0;
        local->contact[i].offset = 0.0;
    }
    ss_copy3(grasp->position, p);
    ss_copy3(grasp->velocity, pdot);
    ss_copy3(grasp->last_force, grasp->force);
    ss_set3(grasp->offset, 0.0, 0.0, 0.0);
    ss_set3(grasp->drift, 0.0, 0.0, 0.0);
    grasp->is_held = true;
}

void ss_local_contact_release(ss_local_contact *local, const double x[3], const double p[3],
                              const double pdot[3], double limit)
{
    if (!local->grasp.is_held) {
        return;
    }
    ss_local_contact_released released = {.share = 1.0};
    double law_force[3] = {0.0, 0.0, 0.0};
    ss_local_contact_felt(local, released.force);
    ss_local_contact_felt_torque(local, released.torque);
    (void)ss_clamp_norm3(released.force, limit);
    local->released = released;
    local->grasp.is_held = false;
    ss_set3(local->grasp.last_force, 0.0, 0.0, 0.0);
    ss_set3(local->residual_torque, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < local->count; ++i) {
        ss_local_contact_point *c = &local->contact[i];
        c->offset = 0.0;
        c->last_force = fmax(0.0, contact_force(local, c, x, p, pdot));
        ss_madd3(law_force, law_force, c->last_force, c->direction);
    }
    /* More than the limit would throw the proxy out. */
    const double size = ss_norm3(law_force), share = size > limit ? limit / size : 1.0;
    for (int32_t i = 0; i < local->count; ++i) {
        ss_local_contact_point *c = &local->contact[i];
        c->offset = c->drift = (share - 1.0) * c->last_force;
        c->last_force *= share;
    }
}

/* Until the model knows of it the force stays; then it goes over to the model's reaction. The law
 * would say what that is where the proxy rests, of a result that a moving tool was predicted for:
 * 6.8 N of a reaction of 1.7 at 100 Hz. */
void ss_local_contact_end_grasp(ss_local_contact *local, double period, double limit,
                                const double p[3], const double pdot[3])
{
    ss_local_contact_grasp *grasp = &local->grasp;
    const double kept = grasp->is_answered ? exp(-period / ENDING_TIME) : 1.0;
    double now[3];
    if (!grasp->is_held) {
        return;
    }
    ss_set3(grasp->offset, 0.0, 0.0, 0.0);
    force_of_grasp(grasp, p, pdot, now);
    for (int i = 0; i < 3; ++i) {
        grasp->last_force[i] = grasp->force[i] + kept * (grasp->last_force[i] - grasp->force[i]);
    }
    (void)ss_clamp_norm3(grasp->last_force, limit);
    ss_sub3(grasp->offset, grasp->last_force, now);
    ss_copy3(grasp->drift, grasp->offset);
}

void ss_local_contact_begin(ss_local_contact *local, const double x[3], const double p[3],
                            const double pdot[3])
{
    for (int32_t i = 0; i < local->count; ++i) {
        ss_local_contact_point *c = &local->contact[i];
        c->offset = 0.0;
        c->offset = -fmax(0.0, contact_force(local, c, x, p, pdot));
    }
}

/* A result of a grasp: the model's whole reaction, with the step hidden in the offset. */
static void take_grasp(ss_local_contact *local, const ss_simulation_result *result,
                       const double p[3], const double pdot[3])
{
    ss_local_contact_grasp *grasp = &local->grasp;
    if (local->count > 0) {
        set_grasp_tensors(local, false);
    }
    ss_copy3(grasp->force, result->set.force);
    ss_copy3(grasp->torque, result->set.torque);
    ss_copy3(grasp->position, result->proxy);
    ss_copy3(grasp->velocity, result->velocity);
    double now[3];
    ss_set3(grasp->offset, 0.0, 0.0, 0.0);
    force_of_grasp(grasp, p, pdot, now);
    ss_sub3(grasp->offset, grasp->last_force, now);
}

/* What contact `i` exerts now. If it was held back at zero, re-evaluate its law: the offset has
 * decayed since. Otherwise, with a result every tick, a resting hand would never get its force.
 * While entering, or at the limit, it stays at zero. */
static double force_now(const ss_local_contact *local, int32_t i, const double x[3],
                        const double p[3], const double pdot[3])
{
    ss_local_contact_point c = local->contact[i];
    const bool is_suppressed = !(c.last_force > 0.0) && c.offset < 0.0 && !local->is_held_back;
    return is_suppressed ? fmax(0.0, contact_force(local, &c, x, p, pdot)) : c.last_force;
}

/* Offsets that keep every contact's force, and the residual for what they cannot keep. */
static void keep_force(ss_local_contact *local, const ss_local_contact *old, const int32_t source[],
                       const double x[3], const double p[3], const double pdot[3])
{
    uint32_t used = 0;
    for (int32_t i = 0; i < local->count; ++i) {
        ss_local_contact_point *c = &local->contact[i];
        const double before = source[i] >= 0 ? force_now(old, source[i], x, p, pdot) : 0.0;
        const double after = contact_force(local, c, x, p, pdot);
        /* Out of contact before: no more than to hold back what would appear at once. */
        c->offset = before > 0.0 ? before - after : -fmax(0.0, after);
        c->drift = source[i] >= 0 ? old->contact[source[i]].drift : c->offset;
        c->last_force = before;
        ss_madd3(local->residual, local->residual, -before, c->direction);
        if (source[i] >= 0) {
            used |= 1U << source[i];
            ss_madd3(local->residual, local->residual, before, old->contact[source[i]].direction);
        }
    }
    for (int32_t i = 0; i < old->count; ++i) {
        if (!(used & (1U << i))) {
            ss_madd3(local->residual, local->residual, old->contact[i].last_force,
                     old->contact[i].direction);
        }
    }
}

void ss_local_contact_take(ss_local_contact *local, const ss_simulation_result *result,
                           const ss_haptic_config *config, int64_t tick, double spring,
                           const double orientation[4], const double x[3], const double p[3],
                           const double pdot[3], bool is_fresh)
{
    double torque[3];
    ss_local_contact_torque(local, torque);
    const ss_local_contact old = *local;
    int32_t source[SS_MAX_CONTACTS];
    uint32_t used = 0;
    if (is_fresh) {
        ss_local_contact_clear(local);
    }
    local->is_known = true;
    local->has_torque = config->tool_gyration > 0.0;
    local->count = result->set.count;
    local->tick = result->tick;
    local->depth = result->set.depth;
    ss_copy3(local->other.model_force, result->set.other_force);
    ss_copy3(local->other.model_torque, result->set.other_torque);
    local->step_stiffness = fmax(0.0, result->set.step_stiffness);
    local->result_period = fmin(0.5, fmax(config->period, result->period));
    ss_copy3(local->proxy, result->proxy);
    ss_copy3(local->velocity, result->velocity);
    memcpy(local->orientation, result->orientation, sizeof local->orientation);
    ss_local_contact_turn(local, orientation);
    const double age = (double)(tick - result->tick) * config->period;
    const double margin = age + local->result_period > SLOW_RESULTS ? 1.0 : STIFFNESS_MARGIN;
    const bool is_steady = local->grasp.is_held && local->result_period < SWIFT_RESULTS;
    local->swift = local->viscous = 0.0;
    for (int32_t i = 0; i < local->count; ++i) {
        local->swift += result->set.contact[i].swift;
    }
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_contact *from = &result->set.contact[i];
        const double share = local->swift > 0.0 ? from->swift / local->swift : 1.0;
        source[i] = is_fresh ? -1 : find_old(&old, &result->set, i, used);
        const ss_local_contact_point *before = source[i] >= 0 ? &old.contact[source[i]] : NULL;
        used |= before != NULL ? 1U << source[i] : 0U;
        take_contact(&local->contact[i], from, margin_of(local, from, margin),
                     is_steady || (before != NULL && before->force > 0.0), share * spring,
                     local->result_period);
        local->viscous += local->contact[i].viscosity;
        if (before != NULL && result->tick > old.tick) {
            local->contact[i].rate =
                (fmax(0.0, local->contact[i].force) - fmax(0.0, before->force)) /
                ((double)(result->tick - old.tick) * config->period);
        }
    }
    if (local->grasp.is_held) {
        if (result->set.is_held) {
            take_grasp(local, result, p, pdot);
        }
    } else if (!is_fresh) {
        keep_force(local, &old, source, x, p, pdot);
    }
    if (!local->grasp.is_held) {
        ss_friction_take(local, &result->set, p);
    }
    if (!is_fresh) {
        ss_local_contact_keep_torque(local, torque);
    }
}

/* As an update of a contact does, it comes by the offsets' time. It goes with the contacts as they
 * end, draws no tool in, and at the limit makes as much of the force as it does of the model's. */
void ss_local_contact_follow_other(ss_local_contact *local, double period, double limit)
{
    ss_local_contact_other *other = &local->other;
    double whole[3], force = 0.0, model_force = 0.0, inward = 0.0;
    const double kept = exp(-period / local->offset_time);
    for (int i = 0; i < 3; ++i) {
        other->force[i] = other->model_force[i] + kept * (other->force[i] - other->model_force[i]);
    }
    ss_copy3(whole, other->force);
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        force += c->last_force;
        model_force += fmax(0.0, c->force);
        inward = fmax(inward, -ss_dot3(other->force, c->direction));
        ss_madd3(whole, whole, fmax(0.0, c->force), c->normal);
    }
    const double size = ss_norm3(whole), full = fmax(model_force, inward);
    other->share = force < full ? force / full : force > 0.0 ? 1.0 : 0.0;
    other->share = fmin(other->share, size > limit ? limit / size : 1.0);
}

void ss_local_contact_rows(ss_local_contact *local, double period, const double x[3],
                           const double p[3], ss_balance *balance)
{
    double pdot[3];
    ss_sub3(pdot, balance->p_free, p);
    ss_scale3(pdot, pdot, 1.0 / period);
    balance->is_held = local->grasp.is_held;
    balance->count = local->grasp.is_held ? 0 : local->count;
    for (int32_t i = 0; i < balance->count; ++i) {
        ss_local_contact_point *c = &local->contact[i];
        ss_balance_row *row = &balance->row[i];
        row->free_force = contact_force(local, c, x, balance->p_free, pdot);
        row->slope = c->stiffness + local->viscosity_fraction * c->viscosity / period;
        ss_copy3(row->normal, c->direction);
    }
    if (local->grasp.is_held) {
        force_of_grasp(&local->grasp, balance->p_free, pdot, balance->grasp_force);
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) {
                balance->grasp_slope[r][c] =
                    local->grasp.stiffness[r][c] + local->grasp.viscosity[r][c] / period;
            }
        }
    }
}
