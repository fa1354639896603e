/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/accuracy/models.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "models/model.h"

/* ---- physical models ---------------------------------------------------------------------- */

static bool has_row(const ss_model_class *class, const char *name)
{
    for (int32_t i = 0; i < class->row_count; ++i) {
        if (strcmp(class->row[i].name, name) == 0) {
            return true;
        }
    }
    return false;
}

/* What a case gives, beside the material. */
enum { YOUNGS_MODULUS, POISSON_RATIO, DENSITY, DAMPING, GIVEN_COUNT };
static const char *const given[GIVEN_COUNT] = {[YOUNGS_MODULUS] = "youngs_modulus_pa",
                                               [POISSON_RATIO] = "poisson_ratio",
                                               [DENSITY] = "density_kg_m3",
                                               [DAMPING] = "mass_damping_per_s"};

static void write_physical(FILE *file, const ss_model_class *class, const ss_accuracy_knobs *k)
{
    const double value[GIVEN_COUNT] = {[YOUNGS_MODULUS] = k->body->youngs_modulus,
                                       [POISSON_RATIO] = k->body->poisson_ratio,
                                       [DENSITY] = k->body->density,
                                       [DAMPING] = k->damping};
    if (k->material != NULL && has_row(class, "material")) {
        fprintf(file, "  material: %s\n", k->material);
    }
    for (int i = 0; i < GIVEN_COUNT; ++i) {
        if (has_row(class, given[i])) {
            fprintf(file, "  %s: %.9g\n", given[i], value[i]);
        }
    }
}

/* Given by the case, as Lame's constants too, or a key of a table ("layer.spacing_m"), which a line
 * of its own cannot say. */
static bool is_given(const char *name)
{
    bool is = strcmp(name, "material") == 0 || strncmp(name, "lame_", 5) == 0 ||
              strchr(name, '.') != NULL;
    for (int i = 0; i < GIVEN_COUNT; ++i) {
        is = is || strcmp(name, given[i]) == 0;
    }
    return is;
}

/* A thin layer outside the body's surface, so that the core has the case's nodes, all of them; it
 * sleeps while there is no tool. */
static void write_hybrid(FILE *file, const ss_model_class *class, const ss_accuracy_knobs *k)
{
    const double spacing = 0.012 * k->body->size;
    write_physical(file, class, k);
    fprintf(file, "  layer: {spacing_m: %.9g, thickness_m: %.9g}\n", spacing, 3.0 * spacing);
}

/* ---- cnn-energy --------------------------------------------------------------------------- */

/* For prescribed displacements the static field depends on the ratios of T0, ks, B and E alone:
 * ks = a T0 / L^4, B = b T0 / L^3, E = c T0 (L: the body's size), and all forces on T0. */
static double tension(const ss_accuracy_knobs *k)
{
    const double size = k->body->size;
    return k->scale * 0.05 * k->body->youngs_modulus * size * size * size;
}

static double rest_stiffness(const ss_accuracy_knobs *k)
{
    return k->free[0] * tension(k) / pow(k->body->size, 4.0);
}

static double area_density(const ss_accuracy_knobs *k)
{
    return k->body->density * k->body->thickness;
}

static double energy_omega(const ss_accuracy_knobs *k)
{
    return sqrt(rest_stiffness(k) / area_density(k));
}

static void write_energy(FILE *file, const ss_model_class *class, const ss_accuracy_knobs *k)
{
    (void)class;
    const double t0 = tension(k);
    fprintf(file,
            "  modulus_j: %.9g\n  pretension_j: %.9g\n  rest_stiffness_n_per_m3: %.9g\n"
            "  area_density_kg_m2: %.9g\n  damping_n_s_per_m3: %.9g\n  window_tolerance: 0\n",
            k->free[2] * t0, t0, rest_stiffness(k), area_density(k), k->damping * area_density(k));
    if (k->body->is_closed) {
        fprintf(file, "  enclosed_bulk_pa: %.9g\n", k->free[1] * t0 / pow(k->body->size, 3.0));
    }
}

/* ---- ChainMail ---------------------------------------------------------------------------- */

static void write_cnn_chainmail(FILE *file, const ss_model_class *class, const ss_accuracy_knobs *k)
{
    fprintf(file, "  alpha: %.9g\n  link_stiffness_n_per_m: %.9g\n", k->free[0],
            k->scale * k->body->youngs_modulus * k->body->size * 0.01);
    if (has_row(class, "unloading")) {
        fputs("  unloading: keep\n", file);
    }
}

static void write_chainmail(FILE *file, const ss_model_class *class, const ss_accuracy_knobs *k)
{
    fprintf(file, "  alpha: %.9g\n", k->free[0]);
    if (has_row(class, "beta")) {
        fprintf(file, "  beta: %.9g\n", k->free[1]);
    }
    if (has_row(class, "relaxation_iterations")) {
        fputs("  relaxation_iterations: 20\n", file);
    }
}

/* ---- the table ---------------------------------------------------------------------------- */

#define EXACT                                                                                      \
    {                                                                                              \
        "linear", "stvk", "neo-hookean"                                                            \
    }

static const ss_accuracy_model table[] = {
    {.name = "fem",
     .colour = "#d55e00",
     .about = "solves the stated material; what is left is the mesh, which bends and squeezes too "
              "stiffly while it is coarse",
     .has_force = true,
     .material = EXACT,
     .write = write_physical},
    {.name = "hybrid",
     .colour = "#7f3f98",
     .about = "the finite elements of fem under a layer of particles, which sleep while no tool is "
              "near, as here; the layer lies outside the body and makes it a little thicker, which "
              "is in its error",
     .note = "the layer outside makes it a thicker body than the case's",
     .has_force = true,
     .material = EXACT,
     .write = write_hybrid},
    {.name = "corotational",
     .colour = "#0072b2",
     .about = "linear elasticity that turns with the body: right while strains are small, whatever "
              "the rotations, and stable at any step",
     .has_force = true,
     .material = {"linear", "linear", "linear"},
     .write = write_physical},
    {.name = "xpbd",
     .colour = "#009e73",
     .about = "a stable neo-Hookean material by position corrections: close to it once a step has "
              "enough of them, softer or stiffer by as much as it lacks",
     .has_force = true,
     .material = {"stable-neo-hookean", "stable-neo-hookean", "neo-hookean"},
     .write = write_physical},
    {.name = "mass-spring",
     .colour = "#8c6d1f",
     .about =
         "springs along edges: one elastic constant, Poisson's ratio near 1/4 whatever is "
         "asked for, and a stiffness that depends on how the mesh was cut: a wall of one or two "
         "irregular elements can be half as stiff as asked",
     .has_force = true,
     .write = write_physical},
    {.name = "cnn-energy",
     .colour = "#cc2277",
     .about = "a network on the surface, with no material inside: its shape is fitted. It follows "
              "a dent on a closed body; bulging, bending and what happens below the surface are "
              "not in it, and other levels than the fitted one are a prediction",
     .on_surface = true,
     .has_force = true,
     .has_scale = true,
     .free_count = 3,
     .free = {{"ks/T0", 1.0, 1e5, 60.0}, {"B/T0", 1e-2, 1e5, 100.0}, {"E/T0", 1e-3, 1e2, 0.03}},
     .write = write_energy,
     .omega = energy_omega},
    {.name = "cnn-chainmail",
     .colour = "#5a9bd4",
     .about = "links that resist only beyond their slack: a fast local shape, far from an elastic "
              "body's in absolute terms, and judged here at rest although its motion is its point",
     .has_force = true,
     .has_scale = true,
     .free_count = 1,
     .free = {{"alpha", 1e-4, 0.02, 4e-3}}, /* an elastic body has no toe */
     .write = write_cnn_chainmail},
    {.name = "chainmail",
     .colour = "#7a7a7a",
     .about = "geometry alone: distances are kept within bounds, forces do not exist in it",
     .free_count = 2,
     .free = {{"alpha", 5e-3, 0.5, 0.1}, {"beta", 0.02, 1.0, 0.2}},
     .write = write_chainmail},
};

const ss_accuracy_model *ss_accuracy_model_find(const char *name)
{
    for (size_t i = 0; i < sizeof table / sizeof *table; ++i) {
        if (strcmp(table[i].name, name) == 0) {
            return &table[i];
        }
    }
    return NULL;
}

bool ss_accuracy_model_is_physical(const ss_accuracy_model *model)
{
    return model->free_count == 0 && !model->has_scale;
}

const char *ss_accuracy_model_material(const ss_accuracy_model *model, const char *material)
{
    static const char *const known[] = {"linear", "stvk", "nh"};
    for (int i = 0; i < 3; ++i) {
        if (strcmp(known[i], material) == 0) {
            return model->material[i];
        }
    }
    /* Another name is a law that only models of any law can have. */
    const bool is_any = model->material[0] != NULL && model->material[1] != NULL &&
                        strcmp(model->material[0], model->material[1]) != 0;
    return is_any ? material : model->material[0];
}

ss_accuracy_body ss_accuracy_body_of(const ss_case *c, const ss_mesh *mesh)
{
    ss_mesh_report report;
    ss_accuracy_body body = {.youngs_modulus = c->youngs_modulus,
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

bool ss_accuracy_model_takes(const ss_accuracy_model *model, const char *key)
{
    const size_t length = strcspn(key, "=");
    const ss_model_class *class = ss_model_find(model->name);
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)length, key);
    return length > 0 && length < sizeof name && class != NULL &&
           ss_accuracy_model_is_physical(model) && !is_given(name) && has_row(class, name);
}

char *ss_accuracy_model_text(const ss_accuracy_model *model, const ss_accuracy_knobs *knobs)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (file == NULL) {
        return NULL;
    }
    fprintf(file, "  name: %s\n", model->name);
    model->write(file, ss_model_find(model->name), knobs);
    for (int32_t i = 0; knobs->set != NULL && i < knobs->set->count; ++i) {
        const char *set = knobs->set->value[i];
        if (ss_accuracy_model_takes(model, set)) {
            const int length = (int)strcspn(set, "=");
            fprintf(file, "  %.*s: %s\n", length, set, set + length + 1);
        }
    }
    if (fclose(file) != 0) {
        free(text);
        return NULL;
    }
    return text;
}
