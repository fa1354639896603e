/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The simulation rate: a step every m haptic periods T, m of 1, 2, 4, 5, 8, 10, 16, 20, ...
 *
 * By counts: the least m for which the model's counted cost of a short step (from counts and a
 * built-in cost, never from a clock) is at most half of m T, so that in lockstep equal scenes run
 * at equal rates on every machine. A given rate is rounded to a whole number of ticks, since in
 * lockstep a result is due after exactly m of them.
 *
 * In real time the counted cost c(m) of a step of that length is scaled by a yardstick y: what some
 * steps of this model took over what was counted for them, by thread CPU time. The model as it was
 * built by counts steps on this machine, on this mesh, with its tool where a hand would press, and
 * goes back to rest. Where y c(m) <= 0.7 m T it stays as it is, or takes a shorter step where one
 * does with half the core. Else the least m is taken with y c(m) <= m T / 2, or, where longer steps
 * do not lower the share of the core any more, the first of those; and the model is built once
 * more, told y, for models plan as many sub-steps as there is time for. Rejected: a kernel of
 * constant size, which knows neither the caches that a mesh of this size lives in nor where the
 * counts are wrong; to change the rate while it runs, which a hand feels.
 */
#include <math.h>
#include <stdlib.h>

#include "contact/touch.h"
#include "rt/clock.h"
#include "rt/order.h"
#include "rt/vec.h"
#include "world/plan.h"

enum { WARM_STEPS = 3, LEAST_STEPS = 5, MOST_STEPS = 32 };
static const double COST_SHARE = 0.5;
static const double SLACK_SHARE = 0.7; /* a model by counts that takes no more stays as it is */
static const double GAIN_SHARE = 0.9;  /* a longer step that lowers the share less does not help */
static const int64_t MEASURE_NS = 4000000;
static const int64_t LONGEST_NS = 500000000; /* of steps that take so long one will do */
static const double PRESS_M_S = 0.1, PRESS_SHARE = 0.02; /* at most that part of the diagonal */
/* A body at rest without a tool costs next to nothing; what sets in later does not. What takes more
 * than the most is a build that looks for faults: at a rate that it reaches contacts would be too
 * soft to be felt, so it is served slower than real time, and says so. */
static const double LEAST_YARDSTICK = 0.5, MOST_YARDSTICK = 4.0;

static const int32_t ticks[] = {1, 2, 4, 5, 8, 10, 16, 20, 25, 40, 50, 100};
enum { RATES = sizeof ticks / sizeof *ticks };

static void set_step(ss_world *world, int32_t step_ticks)
{
    world->step_ticks = step_ticks;
    world->step_period = step_ticks * world->period;
    const ss_model_plan plan = ss_world_plan(world);
    world->step_cost_us = world->model_class->step_cost_us(&plan);
}

void ss_world_rate_by_counts(ss_world *world, double step_s)
{
    const ss_scene *scene = world->scene;
    world->period = step_s > 0.0 ? step_s : 1.0 / scene->haptic_rate_hz;
    if (step_s > 0.0) {
        set_step(world, 1);
        return;
    }
    if (scene->simulation_rate_hz > 0.0) {
        set_step(world,
                 (int32_t)fmax(round(1.0 / (scene->simulation_rate_hz * world->period)), 1.0));
        return;
    }
    const ss_model_plan plan = ss_world_plan(world);
    const double cost_us = world->model_class->step_cost_us(&plan);
    int i = 0;
    while (i + 1 < RATES && cost_us > COST_SHARE * ticks[i] * world->period * 1e6) {
        ++i;
    }
    set_step(world, ticks[i]);
}

static double share_of(const ss_world *world)
{
    return world->yardstick * world->step_cost_us / (1e6 * world->step_period);
}

/* The least step that takes at most half of the core; where one of twice the length takes hardly a
 * smaller share, that. */
static void choose_anew(ss_world *world)
{
    double share = INFINITY;
    int32_t shorter = 0; /* the step of that share */
    for (int i = 0; i < RATES; ++i) {
        set_step(world, ticks[i]);
        if (share_of(world) <= COST_SHARE) {
            return;
        }
        if (ticks[i] >= 2 * shorter) {
            if (share_of(world) > GAIN_SHARE * share) {
                set_step(world, shorter);
                return;
            }
            share = share_of(world);
            shorter = ticks[i];
        }
    }
}

void ss_world_rate_by_yardstick(ss_world *world)
{
    const int32_t counted = world->step_ticks;
    if (share_of(world) > SLACK_SHARE) {
        world->planned_yardstick = world->yardstick;
        choose_anew(world);
    } else if (counted > 1) {
        choose_anew(world);
        if (world->step_ticks > counted) {
            set_step(world, counted);
        }
    }
}

/* ---- the yardstick ---- */

static int compare(const void *a, const void *b)
{
    return ss_order_double(*(const double *)a, *(const double *)b);
}

/* How far the tool goes in a step: as a hand presses, and not too far. */
static void choose_way(const ss_world *world, int side, double out[3])
{
    const double deepest = PRESS_SHARE * ss_mesh_diagonal(world->scene->mesh);
    const double way = fmin(PRESS_M_S * world->step_period, deepest / (WARM_STEPS + LEAST_STEPS));
    ss_scale3(out, ss_touch_sides[side].towards, -way);
}

double ss_world_measure_yardstick(ss_world *world)
{
    const ss_model_class *model_class = world->model_class;
    const double h = world->step_period;
    ss_model_plan plan = ss_world_plan(world);
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{.is_present = false}};
    double way[3] = {0.0, 0.0, 0.0}, took_us[MOST_STEPS];
    int32_t probe = -1;
    int side = 0;
    ss_touch touch;
    const bool has_touch = ss_world_find_touch(world, &probe, &side, &touch);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        plan.tool[p].is_used = has_touch && p == probe;
    }
    if (has_touch) {
        tool[probe] = (ss_model_tool){.is_present = true, .to.orientation = {1.0, 0.0, 0.0, 0.0}};
        ss_copy3(tool[probe].to.position, touch.origin);
        choose_way(world, side, way);
    }
    const int64_t begin_ns = ss_clock_thread_cpu_ns();
    int64_t now_ns = begin_ns;
    int32_t count = 0;
    while (count < MOST_STEPS &&
           now_ns - begin_ns < (count < WARM_STEPS + LEAST_STEPS ? LONGEST_NS : MEASURE_NS)) {
        if (has_touch) {
            tool[probe].from = tool[probe].to;
            if (count < WARM_STEPS + LEAST_STEPS) {
                ss_add3(tool[probe].to.position, tool[probe].to.position, way);
            }
        }
        const int64_t start_ns = now_ns;
        model_class->step(world->model, count * h, h, tool);
        now_ns = ss_clock_thread_cpu_ns();
        took_us[count++] = 1e-3 * (double)(now_ns - start_ns);
    }
    model_class->reset(world->model);
    const int32_t warm = count > WARM_STEPS ? WARM_STEPS : count - 1;
    qsort(took_us + warm, (size_t)(count - warm), sizeof *took_us, compare);
    const double median_us = took_us[warm + (count - warm) / 2];
    const double yardstick = median_us / model_class->step_cost_us(&plan);
    return isfinite(yardstick) ? fmax(LEAST_YARDSTICK, fmin(yardstick, MOST_YARDSTICK)) : 1.0;
}
