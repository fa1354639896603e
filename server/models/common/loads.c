/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/loads.h"

#include <string.h>

#include "models/common/plan.h"
#include "rt/memory.h"

static softsim_status list_nodes(ss_loads *loads, const ss_model_plan *plan, bool is_everywhere,
                                 ss_arena *arena)
{
    const size_t n = (size_t)plan->mesh->node_count;
    uint8_t *mark = ss_memory_get(n, 1);
    loads->node = ss_arena_get(arena, n, sizeof *loads->node);
    if (!mark || !loads->node) {
        ss_memory_free(mark);
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t l = 0; l < plan->load_count; ++l) {
        for (int32_t k = 0; k < plan->load[l].node_count; ++k) {
            mark[plan->load[l].node[k]] = 1;
        }
    }
    for (int32_t i = 0; i < plan->mesh->node_count; ++i) {
        if (mark[i] || is_everywhere) {
            loads->node[loads->node_count++] = i;
        }
    }
    ss_memory_free(mark);
    return SOFTSIM_OK;
}

softsim_status ss_loads_create(ss_loads *loads, const ss_model_plan *plan, const char *name,
                               bool is_everywhere, ss_arena *arena, softsim_error *error)
{
    softsim_status status = SOFTSIM_OK;
    *loads = (ss_loads){.mesh = plan->mesh,
                        .count = plan->load_count,
                        .load = ss_arena_get(arena, (size_t)plan->load_count, sizeof *loads->load)};
    for (int32_t k = 0; loads->load && k < plan->load_count; ++k) {
        ss_acting_load *load = &loads->load[k];
        load->plan = &plan->load[k];
        if (load->plan->is_pressure) {
            const softsim_status found = ss_plan_pressure_triangles(
                plan, name, k, arena, &load->triangle, &load->triangle_count, error);
            status = status == SOFTSIM_OK ? found : status;
        }
    }
    status = status == SOFTSIM_OK ? ss_arena_status(arena) : status;
    return status == SOFTSIM_OK ? list_nodes(loads, plan, is_everywhere, arena) : status;
}

void ss_loads_reset(ss_loads *loads)
{
    for (int32_t l = 0; l < loads->count; ++l) {
        loads->load[l].factor = 0.0;
    }
}

bool ss_loads_update(ss_loads *loads, double time)
{
    bool is_changed = false;
    for (int32_t l = 0; l < loads->count; ++l) {
        ss_acting_load *load = &loads->load[l];
        const double factor = ss_plan_load_factor(load->plan, time);
        is_changed =
            is_changed || factor != load->factor || (load->plan->is_pressure && factor != 0.0);
        load->factor = factor;
    }
    return is_changed;
}

bool ss_loads_is_any_acting(const ss_loads *loads)
{
    bool is_any = false;
    for (int32_t l = 0; l < loads->count; ++l) {
        is_any = is_any || loads->load[l].factor != 0.0;
    }
    return is_any;
}

void ss_loads_clear(const ss_loads *loads, ss_real *force)
{
    for (int32_t k = 0; k < loads->node_count; ++k) {
        memset(force + 4 * (ptrdiff_t)loads->node[k], 0, 4 * sizeof *force);
    }
}

void ss_loads_add(const ss_loads *loads, const ss_real *u, double unit, ss_real *force)
{
    for (int32_t l = 0; l < loads->count; ++l) {
        const ss_acting_load *load = &loads->load[l];
        const ss_load *plan = load->plan;
        if (load->factor != 0.0 && plan->is_pressure) {
            ss_plan_add_pressure(loads->mesh, load->triangle_count, load->triangle, u,
                                 load->factor * plan->pressure / unit, force);
        } else if (load->factor != 0.0) {
            const double share = load->factor / (unit * plan->node_count);
            for (int32_t k = 0; k < plan->node_count; ++k) {
                for (int a = 0; a < 3; ++a) {
                    force[4 * (ptrdiff_t)plan->node[k] + a] += (ss_real)(share * plan->force[a]);
                }
            }
        }
    }
}
