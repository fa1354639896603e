/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/play.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "correct.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"
#include "softsim/softsim.h"

enum { MAX_SET = 72, SENDER = 1, SAMPLE_HZ = 1000, HELD_MS = 100, LONG_S = 3, SETTLE_S = 1 };
static const double touch_n = 0.02, touch_share = 0.01;
/* Of a press to the working force. */
static const double before_m = 0.003, descent_m_s = 0.01, most_descent = 4.0, stay_s = 0.3;
static const int64_t ms_ns = 1000000;

/* ---- playing ---- */

softsim_world *ss_felt_world(const char *scene, const ss_felt_run *run, softsim_error *error)
{
    const char *set[MAX_SET];
    char rate[64];
    softsim_config config = softsim_default_config();
    int32_t count = 0;
    for (; count < run->set_count && count < MAX_SET - 3; ++count) {
        set[count] = run->set[count];
    }
    set[count++] = "publish.mesh_rate_hz=0";
    if (run->is_without_law) {
        set[count++] = "haptic.between_steps=hold";
    }
    if (run->rate_hz > SAMPLE_HZ) {
        config.step_s = 1.0 / run->rate_hz;
    } else {
        snprintf(rate, sizeof rate, "simulation.rate_hz=%.9g", run->rate_hz);
        set[count++] = rate;
    }
    config.set = set;
    config.set_count = count;
    config.import_program = run->import_program;
    return softsim_create(scene, &config, error);
}

/* Energy of the contact under way, and the least of all so far. */
typedef struct balance {
    double touch_n;
    double contact_j, least_j;
    bool is_touching;
} balance;

/* The device goes from `from` to `to` under `force`. */
static void add_work(balance *b, const double force[3], const double from[3], const double to[3])
{
    const bool has_touch = ss_norm3(force) > b->touch_n;
    double way[3];
    ss_sub3(way, to, from);
    if (has_touch && !b->is_touching) {
        b->contact_j = 0.0;
    }
    if (has_touch) {
        b->contact_j -= ss_dot3(force, way);
    } else if (b->is_touching) {
        b->least_j = fmin(b->least_j, b->contact_j);
    }
    b->is_touching = has_touch;
}

/* What is on its way to the device. */
typedef struct bus {
    ss_corrector corrector;
    softsim_force *answer; /* to every sample */
} bus;

static void answer_sample(softsim_world *world, const ss_felt_place *place, const ss_felt_run *run,
                          bus *b, int32_t k, int32_t ticks_per_ms, const double x[3],
                          double out_force[3])
{
    softsim_force all[SOFTSIM_MAX_PROBES];
    const bool is_direct = run->delay_ms == 0;
    softsim_pose pose = {.utime_us = (int64_t)k * 1000 / ticks_per_ms,
                         .sender = SENDER,
                         .seq = k + 1,
                         .probe = place->probe,
                         .force_seq =
                             is_direct ? -1 : ss_corrector_force_seq(&b->corrector, k * ms_ns),
                         .flags = is_direct ? 0 : SOFTSIM_POSE_CORRECTS,
                         .velocity = {NAN, NAN, NAN},
                         .applied_force = {NAN, NAN, NAN}};
    ss_copy3(pose.position, x);
    memcpy(pose.orientation, place->orientation, sizeof pose.orientation);
    if (!is_direct) {
        ss_corrector_note_pose(&b->corrector, k + 1, k * ms_ns, x);
    }
    softsim_tick(world, &pose, &place->probe, 1, all);
    b->answer[k] = all[place->probe];
    if (is_direct) {
        ss_copy3(out_force, all[place->probe].force);
        return;
    }
    if (k >= 2 * run->delay_ms) {
        ss_corrector_take_force(&b->corrector, &b->answer[k - 2 * run->delay_ms], k * ms_ns);
    }
    ss_corrector_force(&b->corrector, k * ms_ns, x, out_force);
}

static double mean_size(const ss_felt_trace *trace, int32_t from, int32_t end)
{
    double sum = 0.0;
    for (int32_t k = from; k < end; ++k) {
        sum += ss_norm3(trace->force[k]);
    }
    return sum / (end - from);
}

/* The tool's origin at `time_s` of the run. */
static void place_at(const ss_felt_place *place, ss_felt_path path, const ss_felt_run *run,
                     double time_s, double out_position[3])
{
    double from_s, seconds;
    if (run->slowness > 1.0) {
        ss_felt_path_last(place, path, &from_s, &seconds);
        time_s = from_s + fmax(0.0, time_s - SETTLE_S) / run->slowness;
    }
    ss_felt_path_at(place, path, run->is_held, time_s, out_position);
}

static double run_seconds(const ss_felt_place *place, ss_felt_path path, const ss_felt_run *run,
                          double *out_hold_end_s)
{
    const double path_s = ss_felt_path_seconds(place, path, out_hold_end_s);
    if (run->slowness > 1.0) {
        double from_s, seconds;
        ss_felt_path_last(place, path, &from_s, &seconds);
        return SETTLE_S + run->slowness * seconds;
    }
    return run->is_held ? *out_hold_end_s + LONG_S : path_s;
}

softsim_status ss_felt_play(const char *scene, const ss_felt_place *place, ss_felt_path path,
                            const ss_felt_run *run, ss_felt_trace *out, softsim_error *error)
{
    double hold_end_s = NAN;
    const double seconds = run_seconds(place, path, run, &hold_end_s);
    const int32_t per_ms = run->rate_hz > SAMPLE_HZ ? (int32_t)round(run->rate_hz / SAMPLE_HZ) : 1;
    const int32_t ticks = (int32_t)ceil(seconds * SAMPLE_HZ) * per_ms;
    *out = (ss_felt_trace){.count = ticks / per_ms, .held_n = NAN};
    out->force = calloc((size_t)out->count + 1, sizeof *out->force);
    bus *b = calloc(1, sizeof *b);
    softsim_force *answer = calloc((size_t)ticks + 1, sizeof *answer);
    softsim_world *world = NULL;
    softsim_status status = SOFTSIM_OK;
    if (!out->force || !b || !answer) {
        status = ss_memory_fault(error);
        goto end;
    }
    b->answer = answer;
    ss_corrector_init(&b->corrector, true, ss_corrector_unlimited);
    world = ss_felt_world(scene, run, error);
    if (!world) {
        status = error->status;
        goto end;
    }
    balance energy = {.touch_n = fmin(touch_n, touch_share * place->working_force_n)};
    double x[3], next[3], force[3];
    place_at(place, path, run, 0.0, x);
    for (int32_t k = 0; k < ticks; ++k) {
        answer_sample(world, place, run, b, k, per_ms, x, force);
        if (k % per_ms == 0) {
            ss_copy3(out->force[k / per_ms], force);
        }
        place_at(place, path, run, (k + 1.0) / (SAMPLE_HZ * per_ms), next);
        add_work(&energy, force, x, next);
        ss_copy3(x, next);
    }
    out->net_j = energy.is_touching ? fmin(energy.least_j, energy.contact_j) : energy.least_j;
    const double held_s = run->is_held ? seconds : hold_end_s;
    if (isfinite(held_s)) {
        const int32_t end_ms = (int32_t)(held_s * SAMPLE_HZ);
        out->held_n = mean_size(out, end_ms - HELD_MS, end_ms);
    }
    softsim_state state;
    softsim_read(world, &state);
    out->verdict = state.worst_verdict;
    snprintf(out->reason, sizeof out->reason, "%s", state.worst_reason ? state.worst_reason : "");
end:
    softsim_destroy(&world);
    free(answer);
    free(b);
    if (status != SOFTSIM_OK) {
        ss_felt_trace_fini(out);
    }
    return status;
}

/* How deep the proxy is in the tissue as its simulation has it. */
static double proxy_depth(const softsim_force *force, const double x[3])
{
    double way[3];
    ss_sub3(way, x, force->proxy);
    return force->depth + ss_dot3(force->normal, way);
}

/* A press straight down at 10 mm/s. */
typedef struct descent {
    softsim_world *world;
    const ss_felt_place *place;
    double depth_m;
    double position[3];
    softsim_force force;
} descent;

static void descend(descent *d, int32_t k)
{
    softsim_force all[SOFTSIM_MAX_PROBES];
    softsim_pose pose = {.utime_us = (int64_t)k * 1000,
                         .sender = SENDER,
                         .seq = k + 1,
                         .probe = d->place->probe,
                         .force_seq = -1,
                         .velocity = {NAN, NAN, NAN},
                         .applied_force = {NAN, NAN, NAN}};
    ss_felt_path_deep(d->place, d->depth_m, d->position);
    ss_copy3(pose.position, d->position);
    memcpy(pose.orientation, d->place->orientation, sizeof pose.orientation);
    softsim_tick(d->world, &pose, &d->place->probe, 1, all);
    d->force = all[d->place->probe];
}

double ss_felt_penetration(const char *scene, const ss_felt_place *place, const ss_felt_run *run)
{
    softsim_error error = {.status = SOFTSIM_OK};
    descent d = {.world = ss_felt_world(scene, run, &error),
                 .place = place,
                 .depth_m = -fmin(place->radius_m, before_m)};
    const int32_t stay = (int32_t)(stay_s * SAMPLE_HZ);
    double penetration = NAN;
    int32_t left = stay;
    for (int32_t k = 0; d.world && left > 0 && d.depth_m < most_descent * place->depth_m; ++k) {
        descend(&d, k);
        if (ss_norm3(d.force.force) >= place->working_force_n || left < stay) {
            penetration = proxy_depth(&d.force, d.position) / place->radius_m;
            --left;
        } else {
            d.depth_m += descent_m_s / SAMPLE_HZ;
        }
    }
    softsim_destroy(&d.world);
    return penetration;
}

double ss_felt_touch_depth(const char *scene, const ss_felt_place *place, const ss_felt_run *run)
{
    softsim_error error = {.status = SOFTSIM_OK};
    descent d = {.world = ss_felt_world(scene, run, &error),
                 .place = place,
                 .depth_m = -fmin(place->radius_m, before_m)};
    bool is_felt = false;
    for (int32_t k = 0; d.world && !is_felt && d.depth_m < place->radius_m; ++k) {
        d.depth_m += descent_m_s / SAMPLE_HZ;
        descend(&d, k);
        is_felt = ss_norm3(d.force.force) > 0.0;
    }
    softsim_destroy(&d.world);
    return is_felt ? d.depth_m : (double)NAN;
}

void ss_felt_trace_fini(ss_felt_trace *trace)
{
    free(trace->force);
    trace->force = NULL;
    trace->count = 0;
}

/* ---- comparing ---- */

/* More than this is a touch of what `reference` plays. */
static double touch_of(const ss_felt_trace *reference)
{
    double most = 0.0;
    for (int32_t k = 0; k < reference->count; ++k) {
        most = fmax(most, ss_norm3(reference->force[k]));
    }
    return fmin(touch_n, touch_share * most);
}

static bool is_touching(const ss_felt_trace *trace, int32_t k, double touch)
{
    return k >= 0 && k < trace->count && ss_norm3(trace->force[k]) > touch;
}

/* The end of the contact that goes on at `k`. */
static int32_t contact_end(const ss_felt_trace *trace, int32_t k, double touch)
{
    while (is_touching(trace, k, touch)) {
        ++k;
    }
    return k;
}

/* By how much the contact of the reference that begins at `from` is felt late, ms: against the
 * beginning that is nearest to it; as long as itself where there is none. */
static int32_t lateness(const ss_felt_trace *trace, int32_t from, int32_t end, double touch)
{
    for (int32_t off = 0; off < end - from; ++off) {
        for (int32_t sign = 1; sign >= -1; sign -= 2) {
            const int32_t k = from + sign * off;
            if (is_touching(trace, k, touch) && !is_touching(trace, k - 1, touch)) {
                return sign * off;
            }
        }
    }
    return end - from;
}

/* Lateness and rise of the reference's contacts. */
static void look_at_contacts(const ss_felt_trace *trace, const ss_felt_trace *reference,
                             double touch, ss_felt_errors *out)
{
    for (int32_t k = 0; k < reference->count; ++k) {
        if (!is_touching(reference, k, touch)) {
            continue;
        }
        const int32_t end = contact_end(reference, k, touch);
        double most = 0.0;
        for (int32_t i = k; i < end; ++i) {
            most = fmax(most, ss_norm3(reference->force[i]));
        }
        int32_t risen = k;
        while (ss_norm3(reference->force[risen]) < 0.9 * most) {
            ++risen;
        }
        const int32_t late = lateness(trace, k, end, touch);
        out->touch_ms = !(fabs(out->touch_ms) > abs(late)) ? late : out->touch_ms;
        out->rise_ms = fmin(out->rise_ms, risen - k); /* of NAN and a number: the number */
        k = end;
    }
}

/* Where in the reference's contacts the milliseconds are that are further off than `limit`. */
static void place_excess(const ss_felt_trace *reference, const double *apart, double limit,
                         double touch, int32_t settle_ms, ss_felt_errors *out)
{
    double count = 0.0, at_touch = 0.0, at_leaving = 0.0;
    int32_t used = 0;
    for (int32_t k = 0; k < reference->count; ++k) {
        const int32_t end = contact_end(reference, k, touch);
        for (int32_t i = k; i < end; ++i, ++used) {
            const bool is_over = apart[used] > limit, is_young = i - k < settle_ms;
            count += is_over;
            at_touch += is_over && is_young;
            at_leaving += is_over && !is_young && end - i <= settle_ms;
        }
        k = end;
    }
    out->at_touch = at_touch / count;
    out->at_leaving = at_leaving / count;
}

bool ss_felt_compare(const ss_felt_trace *trace, const ss_felt_trace *reference,
                     const ss_felt_question *question, ss_felt_errors *out)
{
    const double nan = NAN, touch = touch_of(reference);
    const int32_t count = trace->count < reference->count ? trace->count : reference->count;
    const ss_felt_trace truth = {.count = count, .force = reference->force};
    double *apart = calloc((size_t)count + 1, sizeof *apart);
    double touching = 0.0, sum[2] = {0.0, 0.0}, most[2] = {0.0, 0.0};
    int32_t used = 0;
    *out = (ss_felt_errors){nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan};
    if (apart == NULL) {
        return false;
    }
    for (int32_t k = 0; k < count; ++k) {
        const double size[2] = {ss_norm3(trace->force[k]), ss_norm3(reference->force[k])};
        for (int i = 0; i < 2; ++i) {
            sum[i] += size[i];
            most[i] = fmax(most[i], size[i]);
        }
        if (size[1] > touch) {
            double d[3];
            ss_sub3(d, trace->force[k], reference->force[k]);
            touching += size[1];
            apart[used++] = ss_norm3(d);
        }
    }
    if (used > 0) {
        const double mean = touching / used;
        look_at_contacts(trace, &truth, touch, out);
        place_excess(&truth, apart, question->limit * mean, touch, question->settle_ms, out);
        qsort(apart, (size_t)used, sizeof *apart, ss_compare_doubles);
        out->p50 = apart[used / 2] / mean;
        out->p95 = apart[(int32_t)(0.95 * (used - 1))] / mean;
        out->p99 = apart[(int32_t)(0.99 * (used - 1))] / mean;
        out->largest = apart[used - 1] / mean;
        out->impulse = sum[0] / sum[1] - 1.0;
        out->peak = most[0] / most[1] - 1.0;
        out->held = trace->held_n / reference->held_n - 1.0;
    }
    free(apart);
    return true;
}

double ss_felt_dynamic_share(const ss_felt_trace *slow, double slowness, const ss_felt_place *place,
                             ss_felt_path path, const ss_felt_trace *reference)
{
    const double touch = touch_of(reference);
    double from_s, seconds, touching = 0.0, share = NAN;
    int32_t used = 0;
    double *apart = calloc((size_t)reference->count + 1, sizeof *apart);
    ss_felt_path_last(place, path, &from_s, &seconds);
    const int32_t first = (int32_t)round(from_s * SAMPLE_HZ);
    for (int32_t k = first; apart && k < reference->count; ++k) {
        const int32_t at = (int32_t)round(SETTLE_S * SAMPLE_HZ + slowness * (k - first));
        if (at < slow->count && is_touching(reference, k, touch)) {
            double d[3];
            ss_sub3(d, slow->force[at], reference->force[k]);
            touching += ss_norm3(reference->force[k]);
            apart[used++] = ss_norm3(d);
        }
    }
    if (used > 0) {
        qsort(apart, (size_t)used, sizeof *apart, ss_compare_doubles);
        share = apart[(int32_t)(0.95 * (used - 1))] * used / touching;
    }
    free(apart);
    return share;
}
