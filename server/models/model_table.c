/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/model.h"
/* The table of models: one row a model, and only those that were built in (model_rows.h, made by
 * CMakeLists.txt); and what all share. */
#include <string.h>

#define SS_MODEL_ROW(object) extern const ss_model_class object;
#include "model_rows.h"
#undef SS_MODEL_ROW

static const ss_model_class *const table[] = {
#define SS_MODEL_ROW(object) &object,
#include "model_rows.h"
#undef SS_MODEL_ROW
    NULL};
_Static_assert(sizeof table / sizeof *table - 1 <= SS_MAX_MODELS, "raise SS_MAX_MODELS");

const ss_model_class *const *ss_model_table(int32_t *out_count)
{
    *out_count = (int32_t)(sizeof table / sizeof *table) - 1;
    return table;
}

const ss_model_class *ss_model_find(const char *name)
{
    for (const ss_model_class *const *row = table; *row; ++row) {
        if (strcmp((*row)->name, name) == 0) {
            return *row;
        }
    }
    return NULL;
}

const ss_param_row *ss_model_find_row(const ss_model_class *model, const char *name)
{
    for (int32_t i = 0; i < model->row_count; ++i) {
        if (strcmp(model->row[i].name, name) == 0) {
            return &model->row[i];
        }
    }
    return NULL;
}

void ss_model_reached(const ss_model_tool *tool, double travelled, ss_tool_pose *out)
{
    if (travelled < 1.0) {
        ss_tool_pose_blend(&tool->from, &tool->to, travelled, out);
    } else {
        *out = tool->to;
    }
}
