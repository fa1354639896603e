/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/state.h"
/* The publish loop: the surface, at display rate, on an LCM object of its own. */
#include <math.h>

#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/thread.h"
#include "world/field.h"

static const double SLOWEST_HZ = 5.0;

/* False: not told yet, or no memory. */
static bool find_values(const ss_world *world, ss_scene_field kind,
                        const ss_surface_snapshot *snapshot, ss_field **field, float *out_value)
{
    if (kind == SS_SCENE_FIELD_POTENTIAL) {
        return snapshot->has_source &&
               world->model_class->potential->find(
                   world->model, snapshot->number + 3 * (size_t)world->drawn.node_count, out_value);
    }
    if (*field == NULL) {
        *field = ss_field_create(world->scene, world->model_class, &world->drawn);
    }
    if (*field != NULL) {
        ss_field_compute(*field, kind, snapshot->number, out_value);
    }
    return *field != NULL;
}

static void set_field(ss_loops *loops, ss_scene_field kind, const ss_surface_snapshot *snapshot,
                      ss_field **field, float **value)
{
    const ss_world *world = loops->world;
    if (*value == NULL) {
        *value = ss_memory_get((size_t)world->drawn.node_count, sizeof **value);
    }
    if (*value != NULL && find_values(world, kind, snapshot, field, *value)) {
        ss_publisher_set_field(loops->publisher, ss_clock_now_ns(), snapshot->step,
                               ss_field_name(kind), ss_field_unit(kind), *value);
    }
}

void *ss_loops_publish(void *argument)
{
    ss_loops *loops = argument;
    int refreshes = 0;
    ss_field *field = NULL; /* from when one is first wanted */
    float *value = NULL;
    int64_t due = loops->start_ns;
    double max_bytes = atomic_load_explicit(&loops->max_bytes_per_s, memory_order_acquire);
    while (!atomic_load_explicit(&loops->is_ending, memory_order_acquire)) {
        /* At 5 Hz at least, whatever the rate of new states: topology, sweep and commands. Nothing
         * new comes from a simulation that rests, and it calls when it is woken. */
        const bool is_resting = atomic_load(&loops->is_resting);
        const double rate = is_resting
                                ? SLOWEST_HZ
                                : atomic_load_explicit(&loops->mesh_rate_hz, memory_order_acquire);
        const int64_t period = (int64_t)(1e9 / fmax(rate, SLOWEST_HZ));
        const int64_t now = ss_clock_now_ns();
        due = now - due > period ? now : due + period;
        ss_wake_wait(loops->publish_fd, due);
        const int64_t woken = ss_clock_now_ns();
        due = due < woken ? due : woken;
        const double new_max = atomic_load_explicit(&loops->max_bytes_per_s, memory_order_acquire);
        if (new_max != max_bytes) {
            max_bytes = new_max;
            ss_publisher_set_max_bytes(loops->publisher, max_bytes);
        }
        const int asked = atomic_load_explicit(&loops->refreshes, memory_order_acquire);
        if (asked != refreshes) {
            refreshes = asked;
            ss_publisher_refresh(loops->publisher);
        }
        bool is_new = false;
        const ss_surface_snapshot *snapshot = ss_mailbox_take(loops->world->surface, &is_new);
        const ss_scene_field kind =
            (ss_scene_field)atomic_load_explicit(&loops->world->field, memory_order_acquire);
        if (kind != SS_SCENE_FIELD_NONE && snapshot &&
            (is_new || ss_publisher_wants_field(loops->publisher))) {
            set_field(loops, kind, snapshot, &field, &value);
        }
        ss_publisher_send(loops->publisher, ss_clock_now_ns(), snapshot ? snapshot->step : 0,
                          snapshot && is_new ? snapshot->number : NULL);
    }
    ss_field_destroy(&field);
    ss_memory_free(value);
    return NULL;
}
