/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/model.h"
#include "rt/memory.h"

softsim_status ss_model_create(const ss_model_class *model_class, const ss_model_plan *plan,
                               ss_model **out_model, softsim_error *error)
{
    ss_model *model = ss_memory_get(1, model_class->size);
    softsim_error *own = ss_memory_get(1, sizeof *own); /* faults are counted, wanted or not */
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (model != NULL && own != NULL) {
        status = model_class->build(model, plan, error != NULL ? error : own);
    }
    ss_memory_free(own);
    if (status != SOFTSIM_OK && model != NULL) {
        model_class->destroy(model);
        model = NULL;
    }
    *out_model = model;
    return status;
}
