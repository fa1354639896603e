/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The figures come from the models themselves: each is created on the mesh, asked and destroyed.
 * Formulas of our own beside theirs were rejected: they would be a second truth.
 */
#include "cost.h"

#include "models/model.h"
#include "rt/memory.h"
#include "rt/progress.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char cost_material[] =
    "soft tissue: 3 kPa, Poisson's ratio 0.45; surface networks: 5 J, 11.5 kg/m2, 1725 N s/m3, 5e4 "
    "N/m3";

/* For rows that have no default of their own, in every model; its hints have the others. */
static const ss_hints_value solid[] = {{"youngs_modulus_pa", 3000.0}, {"poisson_ratio", 0.45}};

static void take(ss_param_value *value, const ss_param_row *row, const ss_hints_value *list,
                 size_t count)
{
    for (size_t i = 0; i < count && list[i].name != NULL; ++i) {
        if (strcmp(row->name, list[i].name) == 0 && (row->is_required || isnan(row->fallback))) {
            value->number = list[i].value;
            value->is_given = true;
        }
    }
}

static ss_param_value value_of(const ss_model_class *class, const ss_param_row *row)
{
    ss_param_value value = {.number = row->fallback};
    take(&value, row, solid, sizeof solid / sizeof *solid);
    if (class->hints != NULL) {
        const ss_hints_value *own = class->hints->soft_tissue;
        take(&value, row, own, sizeof class->hints->soft_tissue / sizeof *own);
    }
    return value;
}

static void measure(const ss_model_class *class, const ss_mesh *mesh, const uint8_t *fixed,
                    ss_param_value *param, model_cost *out)
{
    *out = (model_cost){.name = class->name};
    if (class->needs_volume && mesh->tetrahedron_count == 0) {
        (void)snprintf(out->reason, sizeof out->reason, "it needs tetrahedra");
        return;
    }
    if (!class->takes_second_order && mesh->middle != NULL) {
        (void)snprintf(out->reason, sizeof out->reason,
                       "it takes no mesh of second order: softsim-mesh convert --order 1");
        return;
    }
    for (int32_t i = 0; i < class->row_count; ++i) {
        param[i] = value_of(class, &class->row[i]);
        if (class->row[i].is_required && !param[i].is_given) {
            (void)snprintf(out->reason, sizeof out->reason, "it needs %s, which is the scene's",
                           class->row[i].name);
            return;
        }
    }
    const ss_model_plan plan = {.mesh = mesh,
                                .fixed = fixed,
                                .param = param,
                                .working_force = 2.0,
                                .max_force = 8.0,
                                .step = 1e-3,
                                .max_substeps = 64,
                                .threads = 1};
    ss_progress_stage("setting up %s on %d nodes, for its stable step", class->name,
                      mesh->node_count);
    const int64_t before = ss_memory_in_use();
    ss_model *model = NULL;
    softsim_error error = {0};
    if (ss_model_create(class, &plan, &model, &error) != SOFTSIM_OK) {
        /* The name stands before the reason already. */
        const size_t length = strlen(class->name);
        const bool is_named =
            strncmp(error.text, class->name, length) == 0 && error.text[length] == ':';
        const char *why = error.text + (is_named ? length + strspn(error.text + length, ": ") : 0);
        (void)snprintf(out->reason, sizeof out->reason, "%.*s", (int)strcspn(why, "\n"), why);
        return;
    }
    ss_model_info info;
    class->info(model, &info);
    out->is_known = true;
    out->stable_step_s = info.stable_step;
    out->bytes = ss_memory_in_use() - before;
    class->destroy(model);
}

int32_t cost_measure(const ss_mesh *mesh, model_cost out[COST_MAX_MODELS])
{
    int32_t count = 0;
    const ss_model_class *const *table = ss_model_table(&count);
    count = count < COST_MAX_MODELS ? count : COST_MAX_MODELS;
    uint8_t *fixed = ss_memory_get((size_t)mesh->node_count, 1);
    for (int32_t i = 0; i < count; ++i) {
        ss_param_value *param = ss_memory_get((size_t)table[i]->row_count, sizeof *param);
        if (fixed != NULL && param != NULL) {
            measure(table[i], mesh, fixed, param, &out[i]);
        } else {
            out[i] = (model_cost){.name = table[i]->name, .reason = "out of memory"};
        }
        ss_memory_free(param);
    }
    ss_memory_free(fixed);
    return count;
}
