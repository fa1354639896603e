/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/stress_scene.h"
/* The way of a tool: places at times, and straight on between them. */
#include "rt/vec.h"

void ss_stress_case_plan_go(ss_stress_case_plan *plan, double seconds, double x, double z)
{
    const int32_t at = plan->way_count++;
    plan->way_s[at] = at > 0 ? plan->way_s[at - 1] + seconds : 0.0;
    plan->way[at][0] = x;
    plan->way[at][1] = 0.0;
    plan->way[at][2] = z;
}

void ss_stress_case_plan_at(const ss_stress_case_plan *plan, double time_s, double out_position[3])
{
    int32_t at = 0;
    while (at + 1 < plan->way_count && plan->way_s[at + 1] <= time_s) {
        ++at;
    }
    ss_copy3(out_position, plan->way[at]);
    if (at + 1 < plan->way_count && time_s > plan->way_s[at]) {
        double way[3];
        ss_sub3(way, plan->way[at + 1], plan->way[at]);
        ss_madd3(out_position, plan->way[at],
                 (time_s - plan->way_s[at]) / (plan->way_s[at + 1] - plan->way_s[at]), way);
    }
}
