/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/stress_scene.h"
/*
 * Who is tried, and what each model's parameters are for a body of Young's modulus E: a value is
 * factor (E / 10 kPa)^power, for the rows that the model's own table has. Stiffness of the network
 * is E L^3 times a factor that makes it about as stiff as a block of E; damping goes with sqrt(E),
 * so that all times scale together.
 */
#include <math.h>
#include <string.h>

#include "models/model.h"

enum { MAX_KNOBS = 12, MAX_SUBJECTS = 32 };

/* How a parameter follows the run. */
typedef enum knob_use { FIXED, SCALED, POISSON, DENSITY } knob_use;

typedef struct knob {
    const char *name;
    knob_use use;
    double factor, power;
} knob;

/* What sets a model apart. */
enum {
    PLAIN = 0,
    SURFACE = 1, /* it has no use for what is inside */
    PLASTIC = 2, /* it keeps the shape that it was given */
    OWN_WORK = 4 /* what it does by itself is booked as work: unloading */
};

typedef struct subject {
    const char *name, *model;
    const char *text; /* choices, as they stand in the scene */
    int traits;
    knob knob[MAX_KNOBS];
} subject;

#define SOLID                                                                                      \
    {                                                                                              \
        {"youngs_modulus_pa", SCALED, 1e4, 1.0}, {"poisson_ratio", POISSON, 0.4, 0.0},             \
            {"density_kg_m3", DENSITY, 1000.0, 0.0},                                               \
        {                                                                                          \
            "mass_damping_per_s", SCALED, 60.0, 0.5                                                \
        }                                                                                          \
    }

static const subject known[] = {
    {"cnn-energy surface",
     "cnn-energy",
     "",
     SURFACE,
     {{"modulus_j", SCALED, 5.0, 1.0},
      {"pretension_j", SCALED, 0.5, 1.0},
      {"enclosed_bulk_pa", SCALED, 2000.0, 1.0},
      {"area_density_kg_m2", DENSITY, 11.5, 0.0},
      {"damping_n_s_per_m3", SCALED, 1725.0, 0.5},
      {"rest_stiffness_n_per_m3", SCALED, 5e4, 1.0}}},
    {"cnn-energy volume",
     "cnn-energy",
     "  domain: volume\n",
     PLAIN,
     {{"modulus_j", SCALED, 5.0, 1.0},
      {"density_kg_m3", DENSITY, 1000.0, 0.0},
      {"damping_n_s_per_m4", SCALED, 1.5e5, 0.5},
      {"rest_stiffness_n_per_m4", SCALED, 4.3e6, 1.0}}},
    {"cnn-chainmail",
     "cnn-chainmail",
     "",
     OWN_WORK,
     {{"link_stiffness_n_per_m", SCALED, 200.0, 1.0}}},
    {"chainmail", "chainmail", "", PLASTIC, {{NULL, FIXED, 0.0, 0.0}}},
    {"fem stable-neo-hookean", "fem", "  material: stable-neo-hookean\n", PLAIN, SOLID},
    {"fem stvk-guarded", "fem", "  material: stvk-guarded\n", PLAIN, SOLID},
    {"hybrid", "hybrid", "  layer: {spacing_m: 0.0125, thickness_m: 0.0125}\n", PLAIN, SOLID},
    {"mass-spring", "mass-spring", "", PLAIN, SOLID},
    {"xpbd", "xpbd", "  material: stable-neo-hookean\n", PLAIN, SOLID},
    {"corotational", "corotational", "", PLAIN, SOLID},
};
/* A model that is not in the list yet. */
static const knob solid[MAX_KNOBS] = SOLID;

static subject found[MAX_SUBJECTS];
static int32_t found_count;

static void add(const subject *one)
{
    if (found_count < MAX_SUBJECTS) {
        found[found_count++] = *one;
    }
}

int32_t ss_assay_subject_count(void)
{
    int32_t models = 0;
    const ss_model_class *const *table = ss_model_table(&models);
    if (found_count > 0) {
        return found_count;
    }
    for (int32_t m = 0; m < models; ++m) {
        bool is_known = false;
        for (size_t k = 0; k < sizeof known / sizeof *known; ++k) {
            if (strcmp(known[k].model, table[m]->name) == 0) {
                add(&known[k]);
                is_known = true;
            }
        }
        if (!is_known) {
            subject other = {.name = table[m]->name, .model = table[m]->name, .text = ""};
            memcpy(other.knob, solid, sizeof other.knob);
            add(&other);
        }
    }
    return found_count;
}

static const subject *get(int32_t index)
{
    static const subject none = {.name = "", .model = "", .text = ""};
    return index >= 0 && index < ss_assay_subject_count() ? &found[index] : &none;
}

const char *ss_assay_subject_name(int32_t index)
{
    return get(index)->name;
}

const char *ss_assay_subject_model(int32_t index)
{
    return get(index)->model;
}

static const ss_param_row *find_row(const char *model, const char *name)
{
    const ss_model_class *class = ss_model_find(model);
    for (int32_t r = 0; class != NULL && r < class->row_count; ++r) {
        if (strcmp(class->row[r].name, name) == 0) {
            return &class->row[r];
        }
    }
    return NULL;
}

static bool has_use(const subject *s, knob_use use)
{
    for (const knob *k = s->knob; k < s->knob + MAX_KNOBS && k->name != NULL; ++k) {
        const ss_param_row *row = find_row(s->model, k->name);
        if (k->use == use && row != NULL && (use != DENSITY || row->kind == SS_PARAM_FIELD)) {
            return true;
        }
    }
    return false;
}

bool ss_assay_is_surface(int32_t index)
{
    return (get(index)->traits & SURFACE) != 0;
}

bool ss_assay_is_plastic(int32_t index)
{
    return (get(index)->traits & PLASTIC) != 0;
}

bool ss_assay_has_own_work(int32_t index)
{
    return (get(index)->traits & OWN_WORK) != 0;
}

bool ss_assay_applies(int32_t index, ss_assay_kind kind)
{
    const subject *s = get(index);
    return kind == SS_ASSAY_POISSON     ? has_use(s, POISSON)
           : kind == SS_ASSAY_MASS      ? has_use(s, DENSITY)
           : kind == SS_ASSAY_STIFFNESS ? has_use(s, SCALED)
                                        : true;
}

void ss_assay_subject_write(const ss_assay *trial, FILE *file)
{
    const subject *s = get(trial->subject);
    fprintf(file, "model:\n  name: %s\n%s", s->model, s->text);
    for (const knob *k = s->knob; k < s->knob + MAX_KNOBS && k->name != NULL; ++k) {
        if (find_row(s->model, k->name) == NULL) {
            continue;
        }
        const double value = k->factor * pow(trial->stiffness_pa / 1e4, k->power);
        if (k->use == POISSON && trial->kind == SS_ASSAY_POISSON) {
            fprintf(file, "  %s: %.9g\n", k->name, trial->value);
        } else if (k->use == DENSITY && trial->kind == SS_ASSAY_MASS) {
            fprintf(file,
                    "  %s: [{where: {box_m: [[-1, -1, 0.001], [1, 1, 1]]}, value: %.9g}, "
                    "{value: %.9g}]\n",
                    k->name, value * trial->value, value);
        } else {
            fprintf(file, "  %s: %.9g\n", k->name, value);
        }
    }
}
