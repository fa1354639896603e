/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/state.h"
/* The haptic loop: one tick of the world a period. */
#include "rt/clock.h"
#include "rt/thread.h"

void *ss_loops_haptic(void *argument)
{
    ss_loops *loops = argument;
    ss_world *world = loops->world;
    int64_t tick = 0;
    while (!atomic_load_explicit(&loops->is_ending, memory_order_acquire)) {
        int64_t skipped = 0;
        const int64_t due =
            ss_clock_next_period(loops->start_ns, loops->period_ns, &tick, &skipped);
        world->late_periods += skipped;
        ss_world_haptic_tick(world, tick, due, ss_clock_now_ns());
        ss_wake_signal(loops->wake_fd);
    }
    return NULL;
}
