/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/accuracy/models.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool ss_accuracy_is_listed(const char *list, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = list; at != NULL; at = *at == ',' ? at + 1 : NULL) {
        if (strncmp(at, name, length) == 0 && (at[length] == ',' || at[length] == '\0')) {
            return true;
        }
        at += strcspn(at, ",");
    }
    return list == NULL;
}

const ss_model_class *ss_accuracy_model_find(const char *name)
{
    const ss_model_class *model = ss_model_find(name);
    return model != NULL && model->hints != NULL ? model : NULL;
}

bool ss_accuracy_model_is_physical(const ss_model_class *model)
{
    return model->hints->free_count == 0 && !model->hints->has_scale;
}

const char *ss_accuracy_model_material(const ss_model_class *model, const char *material)
{
    static const char *const known[] = {"linear", "stvk", "nh"};
    for (int i = 0; i < 3; ++i) {
        if (strcmp(known[i], material) == 0) {
            return model->hints->material[i];
        }
    }
    /* Another name is a law that only models of any law can have. */
    const bool is_any = model->hints->material[0] != NULL && model->hints->material[1] != NULL &&
                        strcmp(model->hints->material[0], model->hints->material[1]) != 0;
    return is_any ? material : model->hints->material[0];
}

ss_hints_body ss_accuracy_body_of(const ss_case *c, const ss_mesh *mesh)
{
    ss_mesh_report report;
    ss_hints_body body = {.youngs_modulus = c->youngs_modulus,
                          .poisson_ratio = c->poisson_ratio,
                          .density = isnan(c->density) ? 1000.0 : c->density,
                          .size = ss_mesh_diagonal(mesh),
                          .is_closed = mesh->is_closed};
    body.thickness = 0.02 * body.size;
    if (mesh->is_closed && ss_mesh_check(mesh, &report) == SOFTSIM_OK && report.area > 0.0) {
        body.thickness = fabs(report.volume) / report.area;
    }
    return body;
}

bool ss_accuracy_model_takes(const ss_model_class *model, const char *key)
{
    const size_t length = strcspn(key, "=");
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)length, key);
    return length > 0 && length < sizeof name && ss_accuracy_model_is_physical(model) &&
           !ss_hints_is_given(name) && ss_model_find_row(model, name) != NULL;
}

char *ss_accuracy_model_text(const ss_model_class *model, const ss_hints_setting *setting,
                             const ss_arg_list *set)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (file == NULL) {
        return NULL;
    }
    fprintf(file, "  name: %s\n", model->name);
    (model->hints->write != NULL ? model->hints->write : ss_hints_write_solid)(file, model,
                                                                               setting);
    for (int32_t i = 0; set != NULL && i < set->count; ++i) {
        const char *one = set->value[i];
        if (ss_accuracy_model_takes(model, one)) {
            const int length = (int)strcspn(one, "=");
            fprintf(file, "  %.*s: %s\n", length, one, one + length + 1);
        }
    }
    if (fclose(file) != 0) {
        free(text);
        return NULL;
    }
    return text;
}
