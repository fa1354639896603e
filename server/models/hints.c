/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/hints.h"

#include <string.h>

#include "models/model.h"

/* What a body gives, beside the material. */
enum { YOUNGS_MODULUS, POISSON_RATIO, DENSITY, DAMPING, GIVEN_COUNT };
static const char *const given[GIVEN_COUNT] = {[YOUNGS_MODULUS] = "youngs_modulus_pa",
                                               [POISSON_RATIO] = "poisson_ratio",
                                               [DENSITY] = "density_kg_m3",
                                               [DAMPING] = "mass_damping_per_s"};

void ss_hints_write_solid(FILE *file, const ss_model_class *model, const ss_hints_setting *setting)
{
    const double value[GIVEN_COUNT] = {[YOUNGS_MODULUS] = setting->body->youngs_modulus,
                                       [POISSON_RATIO] = setting->body->poisson_ratio,
                                       [DENSITY] = setting->body->density,
                                       [DAMPING] = setting->damping};
    if (setting->material != NULL && ss_model_find_row(model, "material") != NULL) {
        fprintf(file, "  material: %s\n", setting->material);
    }
    for (int i = 0; i < GIVEN_COUNT; ++i) {
        if (ss_model_find_row(model, given[i]) != NULL) {
            fprintf(file, "  %s: %.9g\n", given[i], value[i]);
        }
    }
}

bool ss_hints_is_given(const char *name)
{
    bool is = strcmp(name, "material") == 0 || strncmp(name, "lame_", 5) == 0 ||
              strchr(name, '.') != NULL;
    for (int i = 0; i < GIVEN_COUNT; ++i) {
        is = is || strcmp(name, given[i]) == 0;
    }
    return is;
}
