/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/state.h"
/*
 * The haptic loop: one tick of the world a period, from the first pose of a probe on. Until then
 * there is no force to tell, and it waits to be called.
 */
#include "rt/clock.h"
#include "rt/thread.h"

void *ss_loops_haptic(void *argument)
{
    ss_loops *loops = argument;
    ss_world *world = loops->world;
    int64_t tick = 0;
    while (!atomic_load_explicit(&loops->is_ending, memory_order_acquire)) {
        int64_t skipped = 0;
        if (tick > 0 && !world->is_answering) {
            ss_wake_wait(loops->haptic_fd, INT64_MAX);
            tick = (ss_clock_now_ns() - loops->start_ns) / loops->period_ns;
        }
        const int64_t due =
            ss_clock_next_period(loops->start_ns, loops->period_ns, &tick, &skipped);
        world->late_periods += skipped;
        ss_world_haptic_tick(world, tick, due, ss_clock_now_ns());
        ss_wake_signal(loops->wake_fd);
        /* Either the simulation sees the target before it rests, or it is seen to rest here: both
         * change `is_resting`, one after the other. */
        bool is_resting = false;
        if (!atomic_compare_exchange_strong(&loops->is_resting, &is_resting, false) &&
            world->has_target) {
            ss_wake_signal(loops->simulation_fd);
        }
    }
    return NULL;
}
