/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/stress_scene.h"
/*
 * Who is tried: every model in the ways that its hints say, or as a solid, with parameters for a
 * body of Young's modulus E: a value is factor (E / 10 kPa)^power, for the rows that the model's
 * own table has. Damping goes with sqrt(E), so that all times scale together.
 */
#include <math.h>
#include <string.h>

#include "models/model.h"

static const ss_hints_variant solid = {.name = "", .text = "", .knob = SS_HINTS_SOLID};

typedef struct subject {
    const ss_model_class *model; /* NULL: none of that number */
    const ss_hints_variant *variant;
} subject;

static int32_t variants_of(const ss_model_class *model)
{
    return model->hints != NULL && model->hints->variant_count > 0 ? model->hints->variant_count
                                                                   : 1;
}

int32_t ss_stress_case_subject_count(void)
{
    int32_t models = 0, count = 0;
    const ss_model_class *const *table = ss_model_table(&models);
    for (int32_t m = 0; m < models; ++m) {
        count += variants_of(table[m]);
    }
    return count;
}

static subject get(int32_t index)
{
    int32_t models = 0;
    const ss_model_class *const *table = ss_model_table(&models);
    for (int32_t m = 0; index >= 0 && m < models; ++m) {
        if (index < variants_of(table[m])) {
            const ss_model_hints *hints = table[m]->hints;
            const bool has = hints != NULL && hints->variant_count > 0;
            return (subject){table[m], has ? &hints->variant[index] : &solid};
        }
        index -= variants_of(table[m]);
    }
    return (subject){NULL, &solid};
}

const char *ss_stress_case_subject_name(int32_t index)
{
    const subject s = get(index);
    return s.variant != &solid ? s.variant->name : s.model != NULL ? s.model->name : "";
}

const char *ss_stress_case_subject_model(int32_t index)
{
    const subject s = get(index);
    return s.model != NULL ? s.model->name : "";
}

static const ss_hints_knob *end_of(const ss_hints_variant *variant)
{
    const ss_hints_knob *k = variant->knob;
    while (k < variant->knob + SS_HINTS_MAX_KNOBS && k->name != NULL) {
        ++k;
    }
    return k;
}

static bool has_use(const subject *s, int use)
{
    for (const ss_hints_knob *k = s->variant->knob; s->model != NULL && k < end_of(s->variant);
         ++k) {
        const ss_param_row *row = ss_model_find_row(s->model, k->name);
        if ((int)k->use == use && row != NULL &&
            (use != SS_KNOB_DENSITY || row->kind == SS_PARAM_FIELD)) {
            return true;
        }
    }
    return false;
}

bool ss_stress_case_is_surface(int32_t index)
{
    return get(index).variant->is_surface;
}

bool ss_stress_case_is_plastic(int32_t index)
{
    return get(index).variant->is_plastic;
}

bool ss_stress_case_has_own_work(int32_t index)
{
    return get(index).variant->books_own_work;
}

double ss_stress_case_own_time(int32_t index)
{
    return get(index).variant->own_time_s;
}

bool ss_stress_case_applies(int32_t index, ss_stress_case_kind kind)
{
    const subject s = get(index);
    return kind == SS_STRESS_CASE_POISSON     ? has_use(&s, SS_KNOB_POISSON)
           : kind == SS_STRESS_CASE_MASS      ? has_use(&s, SS_KNOB_DENSITY)
           : kind == SS_STRESS_CASE_STIFFNESS ? has_use(&s, SS_KNOB_STIFFNESS)
                                              : true;
}

void ss_stress_case_subject_write(const ss_stress_case *trial, FILE *file)
{
    const subject s = get(trial->subject);
    fprintf(file, "model:\n  name: %s\n%s", s.model->name, s.variant->text);
    for (const ss_hints_knob *k = s.variant->knob; k < end_of(s.variant); ++k) {
        if (ss_model_find_row(s.model, k->name) == NULL) {
            continue;
        }
        const double value = k->factor * pow(trial->stiffness_pa / 1e4, k->power);
        if (k->use == SS_KNOB_POISSON && trial->kind == SS_STRESS_CASE_POISSON) {
            fprintf(file, "  %s: %.9g\n", k->name, trial->value);
        } else if (k->use == SS_KNOB_DENSITY && trial->kind == SS_STRESS_CASE_MASS) {
            fprintf(file,
                    "  %s: [{where: {box_m: [[-1, -1, 0.001], [1, 1, 1]]}, value: %.9g}, "
                    "{value: %.9g}]\n",
                    k->name, value * trial->value, value);
        } else {
            fprintf(file, "  %s: %.9g\n", k->name, value);
        }
    }
}
