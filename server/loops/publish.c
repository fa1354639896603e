/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/state.h"
/* The publish loop: the surface, at display rate, on an LCM object of its own. */
#include <math.h>

#include "rt/clock.h"

void *ss_loops_publish(void *argument)
{
    ss_loops *loops = argument;
    int refreshes = 0;
    int64_t due = loops->start_ns;
    double max_bytes = atomic_load_explicit(&loops->max_bytes_per_s, memory_order_acquire);
    while (!atomic_load_explicit(&loops->is_ending, memory_order_acquire)) {
        /* At 5 Hz at least, whatever the rate of new states: topology, sweep and commands. */
        const double rate = atomic_load_explicit(&loops->mesh_rate_hz, memory_order_acquire);
        const int64_t period = (int64_t)(1e9 / fmax(rate, 5.0));
        const int64_t now = ss_clock_now_ns();
        due = now - due > period ? now : due + period;
        ss_clock_sleep_until(due);
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
        ss_publisher_send(loops->publisher, ss_clock_now_ns(), snapshot ? snapshot->step : 0,
                          snapshot && is_new ? snapshot->displacement : NULL);
    }
    return NULL;
}
