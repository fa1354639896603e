/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the fit and the reports know of a model beyond how it is run: what a material is in its
 * parameters, which of them are free, and what it cannot do. It stands in the model's class, so
 * that no tool knows a model by its name. All texts are static. Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct ss_model_class;

enum { SS_HINTS_MAX_FREE = 3, SS_HINTS_MAX_FITTED = 11, SS_HINTS_MAX_KNOBS = 12 };

/* A body whose material the model is to take on. */
typedef struct ss_hints_body {
    double youngs_modulus, poisson_ratio, density; /* Pa, 1, kg/m^3 */
    double size;                                   /* m, the body's diagonal */
    double thickness; /* m, of a surface: volume over area, or 2 % of the size if it is open */
    bool is_closed;
} ss_hints_body;

/* The body, and the numbers that a calibration has chosen. */
typedef struct ss_hints_setting {
    const ss_hints_body *body;
    const char *material; /* as scenes call it; NULL: the model takes none */
    double free[SS_HINTS_MAX_FREE];
    double scale;   /* of all forces */
    double damping; /* 1/s, of motion in proportion to mass */
} ss_hints_setting;

/* A number that shapes the field, as a factor of a size that the body and its modulus give: one
 * range does for every body. */
typedef struct ss_hints_free {
    const char *name;
    double low, high, start;
} ss_hints_free;

/* A material parameter that a fit chooses by itself, in the order in which they are told. */
typedef struct ss_hints_fitted {
    const char *name;
    bool needs_time; /* only a curve over time shows it */
    double start;    /* where the scene gives none; 0: then it is not fitted */
} ss_hints_fitted;
/* Those of a body whose material is Lame's or Young's. */
#define SS_HINTS_MODULI                                                                            \
    {"youngs_modulus_pa", false, 0.0}, {"lame_lambda_pa", false, 0.0},                             \
    {                                                                                              \
        "lame_mu_pa", false, 0.0                                                                   \
    }
#define SS_HINTS_VISCOSITIES                                                                       \
    {"viscosity_phi_pa_s", true, 0.0},                                                             \
    {                                                                                              \
        "viscosity_psi_pa_s", true, 0.0                                                            \
    }

/* A parameter of a body of Young's modulus E in the stability report: factor (E / 10 kPa)^power. */
typedef struct ss_hints_knob {
    const char *name;
    enum { SS_KNOB_FIXED, SS_KNOB_STIFFNESS, SS_KNOB_POISSON, SS_KNOB_DENSITY } use;
    double factor, power;
} ss_hints_knob;

/* One of the ways in which the stability report tries the model. */
typedef struct ss_hints_variant {
    const char *name;
    const char *text;    /* choices, as they stand in the scene */
    bool is_surface;     /* it has no use for what is inside */
    bool is_plastic;     /* it keeps the shape that it was given */
    bool books_own_work; /* its work is not F.du of the file's nodes: what it does by itself is
                            booked (unloading), or loads rest on nodes of its own besides */
    double own_time_s;   /* its slowest decay where that is not the material's; 0: it is */
    ss_hints_knob knob[SS_HINTS_MAX_KNOBS];
} ss_hints_variant;

/* A value where neither the table of parameters nor the scene gives one. */
typedef struct ss_hints_value {
    const char *name;
    double value;
} ss_hints_value;

typedef struct ss_model_hints {
    const char *colour; /* in pictures, as gnuplot takes it */
    const char *about;  /* its place, in a sentence or two */
    const char *note;   /* why it is not quite the body that it was given; NULL: it is */
    bool on_surface;
    bool has_force; /* false: what it says about forces is another's doing */
    bool has_scale; /* all forces may be multiplied by one number, which leaves a field of
                       prescribed displacements as it is */
    int32_t free_count;
    ss_hints_free free[SS_HINTS_MAX_FREE];
    const char *material[3]; /* its own names of linear, stvk, nh; NULL: takes none */
    /* The lines under `model:` of a scene; NULL: modulus, Poisson's ratio, density and damping, as
     * far as the model has them (ss_hints_write_solid). */
    void (*write)(FILE *file, const struct ss_model_class *model, const ss_hints_setting *setting);
    /* The same for an organ to feel, of a model whose constants are not physical: it comes back to
     * its rest shape, does not ring, and presses as the body would once `scale` is found by a
     * press. NULL: it has physical constants. */
    void (*write_organ)(FILE *file, const struct ss_model_class *model,
                        const ss_hints_setting *setting);
    /* The lowest frequency (1/s) that follows from the parameters; NULL: to be measured. */
    double (*omega)(const ss_hints_setting *setting);
    ss_hints_fitted fitted[SS_HINTS_MAX_FITTED];
    const ss_hints_variant *variant; /* NULL: one, a solid */
    int32_t variant_count;
    ss_hints_value soft_tissue[4]; /* parameters without a default, for estimates of cost */
    /* What a sweep over its elements streams and computes for one of them: bytes, and flops (a
     * fused multiply-add counts 2). NULL: not known. */
    void (*work)(bool is_viscous, double *out_bytes, double *out_flops);
} ss_model_hints;

/* A solid in the stability report: E, 0.4, 1000 kg/m^3, 60/s. */
#define SS_HINTS_SOLID                                                                             \
    {                                                                                              \
        {"youngs_modulus_pa", SS_KNOB_STIFFNESS, 1e4, 1.0},                                        \
            {"poisson_ratio", SS_KNOB_POISSON, 0.4, 0.0},                                          \
            {"density_kg_m3", SS_KNOB_DENSITY, 1000.0, 0.0},                                       \
        {                                                                                          \
            "mass_damping_per_s", SS_KNOB_STIFFNESS, 60.0, 0.5                                     \
        }                                                                                          \
    }
/* The names of linear, Saint Venant-Kirchhoff and neo-Hookean materials of a model of any law. */
#define SS_HINTS_ANY_LAW                                                                           \
    {                                                                                              \
        "linear", "stvk", "neo-hookean"                                                            \
    }

/* Is `name`, a parameter, given by the body, or part of a table, which a line cannot say? */
bool ss_hints_is_given(const char *name);
void ss_hints_write_solid(FILE *file, const struct ss_model_class *model,
                          const ss_hints_setting *setting);
