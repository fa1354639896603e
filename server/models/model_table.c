/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/model.h"
/* The table of models: one row a model, and only those that were built in; and what all share. */
#include <string.h>

#ifdef SS_MODEL_CNN_ENERGY
extern const ss_model_class ss_model_cnn_energy;
#endif
#ifdef SS_MODEL_CNN_CHAINMAIL
extern const ss_model_class ss_model_cnn_chainmail;
#endif
#ifdef SS_MODEL_CHAINMAIL
extern const ss_model_class ss_model_chainmail;
#endif
#ifdef SS_MODEL_FEM
extern const ss_model_class ss_model_fem;
#endif
#ifdef SS_MODEL_HYBRID
extern const ss_model_class ss_model_hybrid;
#endif
#ifdef SS_MODEL_MASS_SPRING
extern const ss_model_class ss_model_mass_spring;
#endif
#ifdef SS_MODEL_XPBD
extern const ss_model_class ss_model_xpbd;
#endif
#ifdef SS_MODEL_COROTATIONAL
extern const ss_model_class ss_model_corotational;
#endif

static const ss_model_class *const table[] = {
#ifdef SS_MODEL_CNN_ENERGY
    &ss_model_cnn_energy,
#endif
#ifdef SS_MODEL_CNN_CHAINMAIL
    &ss_model_cnn_chainmail,
#endif
#ifdef SS_MODEL_CHAINMAIL
    &ss_model_chainmail,
#endif
#ifdef SS_MODEL_FEM
    &ss_model_fem,
#endif
#ifdef SS_MODEL_HYBRID
    &ss_model_hybrid,
#endif
#ifdef SS_MODEL_MASS_SPRING
    &ss_model_mass_spring,
#endif
#ifdef SS_MODEL_XPBD
    &ss_model_xpbd,
#endif
#ifdef SS_MODEL_COROTATIONAL
    &ss_model_corotational,
#endif
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

void ss_model_reached(const ss_model_tool *tool, double travelled, ss_tool_pose *out)
{
    if (travelled < 1.0) {
        ss_tool_pose_blend(&tool->from, &tool->to, travelled, out);
    } else {
        *out = tool->to;
    }
}
