/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * How the network takes on a body. For prescribed displacements the static field depends on the
 * ratios of T0, ks, B and E alone: ks = a T0 / L^4, B = b T0 / L^3, E = c T0 (L: the body's size),
 * and all forces on T0.
 */
#include <math.h>

static double tension(const ss_hints_setting *k)
{
    const double size = k->body->size;
    return k->scale * 0.05 * k->body->youngs_modulus * size * size * size;
}

static double rest_stiffness(const ss_hints_setting *k)
{
    return k->free[0] * tension(k) / pow(k->body->size, 4.0);
}

static double area_density(const ss_hints_setting *k)
{
    return k->body->density * k->body->thickness;
}

static double omega(const ss_hints_setting *k)
{
    return sqrt(rest_stiffness(k) / area_density(k));
}

static void write(FILE *file, const ss_model_class *model, const ss_hints_setting *k)
{
    (void)model;
    const double t0 = tension(k);
    fprintf(file,
            "  modulus_j: %.9g\n  pretension_j: %.9g\n  rest_stiffness_n_per_m3: %.9g\n"
            "  area_density_kg_m2: %.9g\n  damping_n_s_per_m3: %.9g\n  window_tolerance: 0\n",
            k->free[2] * t0, t0, rest_stiffness(k), area_density(k), k->damping * area_density(k));
    if (k->body->is_closed) {
        fprintf(file, "  enclosed_bulk_pa: %.9g\n", k->free[1] * t0 / pow(k->body->size, 3.0));
    }
}

/* The ratios of the bundled kidney, whose modulus and size give T0 = 1 J. */
static void write_organ(FILE *file, const ss_model_class *model, const ss_hints_setting *k)
{
    (void)model;
    const double t0 = tension(k), size = k->body->size;
    fprintf(file,
            "  modulus_j: %.4g\n  pretension_j: %.4g\n  rest_stiffness_n_per_m3: %.4g\n"
            "  area_density_kg_m2: %.4g\n  damping_n_s_per_m3: %.4g\n",
            5.0 * t0, t0, 15.0 * t0 / pow(size, 4.0), area_density(k),
            5.0 * k->damping * area_density(k));
    if (k->body->is_closed) {
        fprintf(file, "  enclosed_bulk_pa: %.4g\n", 7.0 * t0 / pow(size, 3.0));
    }
}

/* As stiff as a block of 10 kPa, about: E L^3 times a factor. */
static const ss_hints_variant variants[] = {
    {.name = "cnn-energy surface",
     .text = "",
     .is_surface = true,
     .knob = {{"modulus_j", SS_KNOB_STIFFNESS, 5.0, 1.0},
              {"pretension_j", SS_KNOB_STIFFNESS, 0.5, 1.0},
              {"enclosed_bulk_pa", SS_KNOB_STIFFNESS, 2000.0, 1.0},
              {"area_density_kg_m2", SS_KNOB_DENSITY, 11.5, 0.0},
              {"damping_n_s_per_m3", SS_KNOB_STIFFNESS, 1725.0, 0.5},
              {"rest_stiffness_n_per_m3", SS_KNOB_STIFFNESS, 5e4, 1.0}}},
    {.name = "cnn-energy volume",
     .text = "  domain: volume\n",
     .knob = {{"modulus_j", SS_KNOB_STIFFNESS, 5.0, 1.0},
              {"density_kg_m3", SS_KNOB_DENSITY, 1000.0, 0.0},
              {"damping_n_s_per_m4", SS_KNOB_STIFFNESS, 1.5e5, 0.5},
              {"rest_stiffness_n_per_m4", SS_KNOB_STIFFNESS, 4.3e6, 1.0}}},
};

const ss_model_hints ss_cnn_hints = {
    .colour = "#cc2277",
    .about = "a network on the surface, with no material inside: its shape is fitted. It follows "
             "a dent on a closed body; bulging, bending and what happens below the surface are "
             "not in it, and other levels than the fitted one are a prediction",
    .on_surface = true,
    .has_force = true,
    .has_scale = true,
    .free_count = 3,
    .free = {{"ks/T0", 1.0, 1e5, 60.0}, {"B/T0", 1e-2, 1e5, 100.0}, {"E/T0", 1e-3, 1e2, 0.03}},
    .write = write,
    .write_organ = write_organ,
    .omega = omega,
    .fitted = {{"modulus_j", false, 0.0},
               {"modulus_n_per_m", false, 0.0},
               {"modulus_pa", false, 0.0},
               {"pretension_j", false, 0.0},
               {"enclosed_bulk_pa", false, 0.0},
               {"rest_stiffness_n_per_m3", false, 0.0},
               {"rest_stiffness_n_per_m4", false, 0.0},
               {"rest_stiffness_n_per_m", false, 0.0},
               {"damping_n_s_per_m3", true, 0.0},
               {"damping_n_s_per_m4", true, 0.0},
               {"damping_n_s_per_m", true, 0.0}},
    .variant = variants,
    .variant_count = sizeof variants / sizeof *variants,
    .soft_tissue = {{"modulus_j", 5.0},
                    {"area_density_kg_m2", 11.5},
                    {"damping_n_s_per_m3", 1725.0},
                    {"rest_stiffness_n_per_m3", 5e4}}};
