/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/state.h"
/*
 * The simulation loop: one step of the model a period of its own. While the model sleeps and no
 * tool is in the world it waits to be called, and its steps go by in one.
 */
#include "rt/clock.h"
#include "rt/thread.h"

static const int64_t RATE_PERIOD_NS = 250000000;
/* How often a simulation that rests tells where it is. */
static const int64_t REST_NS = 250000000;

void ss_loops_measure_rate(ss_loops *loops)
{
    ss_rate_meter *meter = &loops->meter;
    const int64_t now_ns = ss_clock_now_ns();
    const int64_t oldest = meter->count < SS_RATE_MARKS ? 0 : meter->count % SS_RATE_MARKS;
    const int64_t newest = (meter->count + SS_RATE_MARKS - 1) % SS_RATE_MARKS;
    if (meter->count > 0 && now_ns > meter->time_ns[oldest]) {
        const double steps = (double)(loops->world->steps - meter->step[oldest]);
        const double time_s = 1e-9 * (double)(now_ns - meter->time_ns[oldest]);
        atomic_store_explicit(&loops->rate_hz, steps / time_s, memory_order_relaxed);
    }
    if (meter->count == 0 || now_ns - meter->time_ns[newest] >= RATE_PERIOD_NS) {
        const int64_t slot = meter->count++ % SS_RATE_MARKS;
        meter->time_ns[slot] = now_ns;
        meter->step[slot] = loops->world->steps;
    }
}

/* Rests from period `*step` on, for as long as nothing can happen by itself; false: it may not. */
static bool rest(ss_loops *loops, int64_t *step)
{
    ss_world *world = loops->world;
    const int64_t period = loops->step_period_ns;
    const int64_t idle = ss_world_idle_steps(world);
    const int64_t most = REST_NS / period;
    const int64_t count = idle < most ? idle : most;
    if (count < 1) {
        return false;
    }
    (void)atomic_exchange(&loops->is_resting, true); /* against the haptic loop's look at it */
    if (!ss_world_has_tool(world)) {
        ss_wake_wait(loops->simulation_fd, loops->start_ns + (*step + count) * period);
    }
    atomic_store(&loops->is_resting, false);
    const int64_t passed = (ss_clock_now_ns() - loops->start_ns) / period - *step;
    const int64_t skipped = passed < idle ? passed : idle;
    if (skipped > 0) {
        ss_world_skip_steps(world, skipped);
        *step += skipped;
        ss_pace_init(&loops->pace, period);
    }
    return true;
}

void *ss_loops_simulation(void *argument)
{
    ss_loops *loops = argument;
    ss_world *world = loops->world;
    int64_t step = 0;
    while (!atomic_load_explicit(&loops->is_ending, memory_order_acquire)) {
        int64_t skipped = 0;
        const bool has_rested = rest(loops, &step);
        ss_clock_next_period(loops->start_ns, loops->step_period_ns, &step, &skipped);
        world->lag = 1.0 - ss_pace_share(&loops->pace);
        ss_world_step_begin(world);
        ss_world_step_compute(world);
        ss_world_step_post(world);
        ss_pace_note(&loops->pace, ss_clock_now_ns());
        ss_loops_measure_rate(loops);
        if (has_rested && ss_world_idle_steps(world) == 0) {
            ss_wake_signal(loops->publish_fd);
        }
    }
    return NULL;
}
