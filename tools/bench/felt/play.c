/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/play.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "correct.h"
#include "rt/order.h"
#include "rt/vec.h"
#include "softsim/softsim.h"

enum { MAX_SET = 72, SENDER = 1, SAMPLE_HZ = 1000, HELD_MS = 100, LONG_S = 3 };
static const double touch_n = 0.02;
static const int64_t ms_ns = 1000000;

/* ---- playing ---- */

softsim_world *ss_felt_world(const char *scene, const ss_felt_run *run, softsim_error *error)
{
    const char *set[MAX_SET];
    char rate[64];
    softsim_config config = softsim_default_config();
    int32_t count = 0;
    for (; count < run->set_count && count < MAX_SET - 2; ++count) {
        set[count] = run->set[count];
    }
    set[count++] = "publish.mesh_rate_hz=0";
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
    double contact_j, least_j;
    bool is_touching;
} balance;

/* The device goes from `from` to `to` under `force`. */
static void add_work(balance *b, const double force[3], const double from[3], const double to[3])
{
    const bool is_touching = ss_norm3(force) > touch_n;
    double way[3];
    ss_sub3(way, to, from);
    if (is_touching && !b->is_touching) {
        b->contact_j = 0.0;
    }
    if (is_touching) {
        b->contact_j -= ss_dot3(force, way);
    } else if (b->is_touching) {
        b->least_j = fmin(b->least_j, b->contact_j);
    }
    b->is_touching = is_touching;
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

softsim_status ss_felt_play(const char *scene, const ss_felt_place *place, ss_felt_path path,
                            const ss_felt_run *run, ss_felt_trace *out, softsim_error *error)
{
    double hold_end_s = NAN;
    const double path_s = ss_felt_path_seconds(place, path, &hold_end_s);
    const double seconds = run->is_held ? hold_end_s + LONG_S : path_s;
    const int32_t per_ms = run->rate_hz > SAMPLE_HZ ? (int32_t)round(run->rate_hz / SAMPLE_HZ) : 1;
    const int32_t ticks = (int32_t)ceil(seconds * SAMPLE_HZ) * per_ms;
    *out = (ss_felt_trace){.count = ticks / per_ms, .held_n = NAN};
    out->force = calloc((size_t)out->count + 1, sizeof *out->force);
    bus *b = calloc(1, sizeof *b);
    softsim_force *answer = calloc((size_t)ticks + 1, sizeof *answer);
    softsim_world *world = NULL;
    softsim_status status = SOFTSIM_OK;
    if (!out->force || !b || !answer) {
        status = SOFTSIM_ERROR_MEMORY;
        softsim_error_add(error, status, "out of memory");
        goto end;
    }
    b->answer = answer;
    ss_corrector_init(&b->corrector, true);
    world = ss_felt_world(scene, run, error);
    if (!world) {
        status = error->status;
        goto end;
    }
    balance energy = {0.0, 0.0, false};
    double x[3], next[3], force[3];
    ss_felt_path_at(place, path, run->is_held, 0.0, x);
    for (int32_t k = 0; k < ticks; ++k) {
        answer_sample(world, place, run, b, k, per_ms, x, force);
        if (k % per_ms == 0) {
            ss_copy3(out->force[k / per_ms], force);
        }
        ss_felt_path_at(place, path, run->is_held, (k + 1.0) / (SAMPLE_HZ * per_ms), next);
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

void ss_felt_trace_fini(ss_felt_trace *trace)
{
    free(trace->force);
    trace->force = NULL;
    trace->count = 0;
}

/* ---- comparing ---- */

bool ss_felt_compare(const ss_felt_trace *trace, const ss_felt_trace *reference,
                     ss_felt_errors *out)
{
    const int32_t count = trace->count < reference->count ? trace->count : reference->count;
    double *apart = calloc((size_t)count + 1, sizeof *apart);
    double touching = 0.0, sum[2] = {0.0, 0.0}, most[2] = {0.0, 0.0};
    int32_t used = 0;
    *out = (ss_felt_errors){(double)NAN, (double)NAN, (double)NAN,
                            (double)NAN, (double)NAN, (double)NAN};
    if (apart == NULL) {
        return false;
    }
    for (int32_t k = 0; k < count; ++k) {
        const double size[2] = {ss_norm3(trace->force[k]), ss_norm3(reference->force[k])};
        for (int i = 0; i < 2; ++i) {
            sum[i] += size[i];
            most[i] = fmax(most[i], size[i]);
        }
        if (size[1] > touch_n) {
            double d[3];
            ss_sub3(d, trace->force[k], reference->force[k]);
            touching += size[1];
            apart[used++] = ss_norm3(d);
        }
    }
    if (used > 0) {
        const double mean = touching / used;
        qsort(apart, (size_t)used, sizeof *apart, ss_compare_doubles);
        out->p50 = apart[used / 2] / mean;
        out->p99 = apart[(int32_t)(0.99 * (used - 1))] / mean;
        out->largest = apart[used - 1] / mean;
        out->impulse = sum[0] / sum[1] - 1.0;
        out->peak = most[0] / most[1] - 1.0;
        out->held = trace->held_n / reference->held_n - 1.0;
    }
    free(apart);
    return true;
}
