/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/ablation/pair.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/felt/path.h"
#include "case/samples.h"
#include "net/codec.h"
#include "net/net.h"
#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/vec.h"
#include "softsim/softsim.h"

enum { TURN_TICKS = 50, REST_TURNS = 27, PRESS_TURNS = 10, LAST_TURNS = 6, CREATIONS = 3 };
enum { TURNS = REST_TURNS + PRESS_TURNS, TICKS = TURNS * TURN_TICKS };
static const double press_s = 0.2;      /* in and out; the last turn ends within */
static const double press_depth = 0.5;  /* of the tool's radius */
static const double press_above = 0.05; /* of it: where the way begins */

typedef struct side {
    softsim_world *world;
    ss_publisher *publisher; /* NULL: nothing is published */
    double (*force)[3];      /* of each tick */
    int64_t message_bytes;
    ss_samples rest, press;
} side;

bool ss_ablation_agrees(const ss_ablation_figures *figures)
{
    return figures->is_same_state ||
           (figures->force_apart <= SS_ABLATION_APART && figures->field_apart <= SS_ABLATION_APART);
}

/* ---- set-up ---- */

/* `rate`: of steps, a scene's value; NULL as the plan finds it. */
static softsim_world *create(const char *scene, const ss_omission *omission, const char *rate,
                             double *out_ms, double *out_bytes, softsim_error *error)
{
    const char *set[SS_OMISSION_VALUES + 1];
    softsim_config config = softsim_default_config();
    config.set = set;
    for (int32_t k = 0; omission != NULL && k < omission->value_count; ++k) {
        set[config.set_count++] = omission->value[k];
    }
    if (rate != NULL) {
        set[config.set_count++] = rate;
    }
    const int64_t before = ss_memory_in_use(), begin_ns = ss_clock_thread_cpu_ns();
    softsim_world *world = softsim_create(scene, &config, error);
    *out_ms = 1e-6 * (double)(ss_clock_thread_cpu_ns() - begin_ns);
    *out_bytes = (double)(ss_memory_in_use() - before);
    return world;
}

static softsim_status create_all(const char *scene, const ss_omission *omission, const char *rate,
                                 side both[2], ss_ablation_figures *out, softsim_error *error)
{
    double create_ms[2];
    out->create_ms[0] = out->create_ms[1] = out->create_least = (double)INFINITY;
    for (int k = 0; k < 2 * CREATIONS; ++k) {
        const int w = k % 2;
        softsim_destroy(&both[w].world);
        both[w].world =
            create(scene, w == 1 ? omission : NULL, rate, &create_ms[w], &out->bytes[w], error);
        if (both[w].world == NULL) {
            return error->status;
        }
        out->create_ms[w] = fmin(out->create_ms[w], create_ms[w]);
        if (w == 1) {
            out->create_least = fmin(out->create_least, create_ms[1] / create_ms[0]);
        }
    }
    return SOFTSIM_OK;
}

static softsim_status create_both(const char *scene, const ss_omission *omission, side both[2],
                                  ss_ablation_figures *out, softsim_error *error)
{
    softsim_status status = create_all(scene, omission, NULL, both, out, error);
    for (int w = 0; w < 2 && status == SOFTSIM_OK; ++w) {
        out->rate_hz[w] = 1.0 / ss_world_of(both[w].world)->step_period;
    }
    if (status == SOFTSIM_OK && out->rate_hz[0] != out->rate_hz[1]) {
        char rate[64];
        (void)snprintf(rate, sizeof rate, "simulation.rate_hz=%.17g", out->rate_hz[0]);
        status = create_all(scene, omission, rate, both, out, error);
    }
    return status;
}

/* Its messages go nowhere, and are counted. */
static softsim_status open_publisher(side *s, softsim_error *error)
{
    const ss_world *world = ss_world_of(s->world);
    const ss_publisher_config config = {.lcm_url = "memq://",
                                        .prefix = "ABLATION",
                                        .max_bytes_per_s = world->scene->max_bytes_per_s};
    const ss_publish_mesh surface = ss_world_publish_mesh(world);
    return world->surface != NULL ? ss_publisher_open(&config, &surface, &s->publisher, error)
                                  : SOFTSIM_OK;
}

static softsim_status prepare(side *s, softsim_error *error)
{
    s->force = calloc(TICKS, sizeof *s->force);
    const bool is_good = s->force != NULL && ss_samples_init(&s->rest, LAST_TURNS) &&
                         ss_samples_init(&s->press, LAST_TURNS);
    return is_good ? open_publisher(s, error) : ss_memory_fault(error);
}

static void finish(side *s)
{
    ss_publisher_close(&s->publisher);
    softsim_destroy(&s->world);
    ss_samples_fini(&s->rest);
    ss_samples_fini(&s->press);
    free(s->force);
}

/* ---- turns ---- */

static void publish(side *s, int64_t step, int64_t now_ns)
{
    const ss_world *world = ss_world_of(s->world);
    bool is_new = false;
    const ss_surface_snapshot *snapshot = ss_mailbox_take(world->surface, &is_new);
    ss_publisher_send(s->publisher, now_ns, step,
                      snapshot != NULL && is_new ? snapshot->number : NULL);
}

/* `place`: where the hand presses; NULL without. */
static void turn(side *s, const ss_felt_place *place, int32_t index)
{
    const ss_world *world = ss_world_of(s->world);
    const bool has_pose = place != NULL && index >= REST_TURNS;
    const int32_t every = (int32_t)fmax(1.0, round(1.0 / (60.0 * world->period)));
    softsim_force force[SOFTSIM_MAX_PROBES] = {{.seq = 0}};
    softsim_pose pose = {.sender = 1, .force_seq = -1};
    const int32_t probe = has_pose ? place->probe : 0;
    int64_t spent_ns = 0;
    if (has_pose) {
        memcpy(pose.orientation, place->orientation, sizeof pose.orientation);
    }
    ss_set3(pose.velocity, (double)NAN, (double)NAN, (double)NAN);
    ss_set3(pose.applied_force, (double)NAN, (double)NAN, (double)NAN);
    for (int32_t k = index * TURN_TICKS; k < (index + 1) * TURN_TICKS; ++k) {
        const double time = (k - REST_TURNS * TURN_TICKS) * world->period;
        if (has_pose) {
            const double in = 0.5 * press_depth * (1.0 - cos(2.0 * M_PI * time / press_s));
            ss_felt_path_deep(place, place->radius_m * (in - press_above), pose.position);
        }
        pose.seq = k + 1;
        pose.utime_us = (int64_t)(1e6 * world->period * k);
        const int64_t begin_ns = ss_clock_thread_cpu_ns();
        softsim_tick(s->world, &pose, &probe, has_pose ? 1 : 0, force);
        spent_ns += ss_clock_thread_cpu_ns() - begin_ns;
        if (has_pose) {
            ss_copy3(s->force[k], force[probe].force);
            s->message_bytes += SS_WIRE_FORCE_SIZE;
        }
        if (s->publisher != NULL && k % every == 0) {
            publish(s, k, (int64_t)(1e9 * world->period * k));
        }
    }
    if (index >= TURNS - LAST_TURNS) {
        ss_samples_add(&s->press, 1e-3 * (double)spent_ns / TURN_TICKS);
    } else if (index >= REST_TURNS - LAST_TURNS && index < REST_TURNS) {
        ss_samples_add(&s->rest, 1e-3 * (double)spent_ns / TURN_TICKS);
    }
}

/* ---- results ---- */

static double share_of(double apart, double largest)
{
    return apart > 0.0 ? apart / largest : 0.0;
}

/* The largest distance of two lists of vectors over the longest of the first. */
static double measure_apart(int32_t count, const double (*a)[3], const double (*b)[3])
{
    double apart = 0.0, largest = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        double way[3];
        ss_sub3(way, a[i], b[i]);
        apart = fmax(apart, ss_norm3(way));
        largest = fmax(largest, ss_norm3(a[i]));
    }
    return share_of(apart, largest);
}

/* Of the turns of both, as they came. */
static double least_ratio(const ss_samples *without, const ss_samples *with)
{
    double least = (double)INFINITY;
    for (int64_t k = 0; k < with->count; ++k) {
        least = fmin(least, with->value[k] / without->value[k]);
    }
    return least;
}

static softsim_status compare(side both[2], ss_ablation_figures *out, softsim_error *error)
{
    const int32_t count = ss_world_of(both[0].world)->scene->mesh->node_count;
    double(*u)[3] = calloc(2 * (size_t)count, sizeof *u);
    if (u == NULL) {
        return ss_memory_fault(error);
    }
    softsim_read_nodes(both[0].world, NULL, u, NULL);
    softsim_read_nodes(both[1].world, NULL, u + count, NULL);
    out->field_apart = measure_apart(count, (const double(*)[3])u, (const double(*)[3])u + count);
    free(u);
    out->force_apart =
        measure_apart(TICKS, (const double(*)[3])both[0].force, (const double(*)[3])both[1].force);
    out->is_same_state =
        softsim_hash(both[0].world) == softsim_hash(both[1].world) && out->force_apart == 0.0;
    out->rest_least = least_ratio(&both[0].rest, &both[1].rest);
    out->press_least = least_ratio(&both[0].press, &both[1].press);
    for (int w = 0; w < 2; ++w) {
        const double seconds = TICKS * ss_world_of(both[w].world)->period;
        const int64_t surface =
            both[w].publisher != NULL ? ss_publisher_bytes(both[w].publisher) : 0;
        out->message_bytes[w] = (double)(both[w].message_bytes + surface) / seconds;
        out->rest_us[w] = ss_samples_quantile(&both[w].rest, 0.5);
        out->press_us[w] = ss_samples_quantile(&both[w].press, 0.5);
    }
    return SOFTSIM_OK;
}

softsim_status ss_ablation_measure(const char *scene, const ss_omission *omission,
                                   ss_ablation_figures *out, softsim_error *error)
{
    side both[2] = {{.world = NULL}, {.world = NULL}};
    softsim_status status = create_both(scene, omission, both, out, error);
    for (int w = 0; w < 2 && status == SOFTSIM_OK; ++w) {
        status = prepare(&both[w], error);
    }
    if (status == SOFTSIM_OK) {
        ss_felt_place place;
        const bool has_place = ss_felt_find_place(ss_world_of(both[0].world)->scene, &place);
        for (int32_t k = 0; k < TURNS; ++k) {
            turn(&both[k % 2], has_place ? &place : NULL, k);
            turn(&both[1 - k % 2], has_place ? &place : NULL, k);
        }
        status = compare(both, out, error);
    }
    finish(&both[0]);
    finish(&both[1]);
    return status;
}
