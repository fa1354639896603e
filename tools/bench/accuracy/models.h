/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the accuracy report must know of each model: where it runs, what a case's material is in its
 * parameters, and which parameters are free. One row a model; a model of the program without a row
 * is reported as such.
 *
 * Free parameters are factors of a size that the body and its modulus give, so that one range does
 * for every case: of a body in millimetres as of one in metres. Those in `free` shape the field;
 * `has_scale` says that besides all forces may be multiplied by one number, which leaves a field of
 * prescribed displacements as it is. Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "case/case.h"
#include "rt/args.h"

enum { SS_ACCURACY_MAX_FREE = 3 };

struct ss_model_class;

typedef struct ss_accuracy_body {
    double youngs_modulus, poisson_ratio, density;
    double size; /* m, the body's diagonal */
    double
        thickness; /* m, of a surface model: volume over area, or 2 % of the size if it is open */
    bool is_closed;
} ss_accuracy_body;

typedef struct ss_accuracy_knobs {
    const ss_accuracy_body *body;
    const char *material; /* as scenes call it; NULL: the model takes none */
    double free[SS_ACCURACY_MAX_FREE];
    double scale;
    double damping;         /* 1/s, of motion in proportion to mass */
    const ss_arg_list *set; /* KEY=VALUE for models with that parameter; NULL: none */
} ss_accuracy_knobs;

typedef struct ss_accuracy_free {
    const char *name;
    double low, high, start;
} ss_accuracy_free;

typedef struct ss_accuracy_model {
    const char *name;
    const char *colour; /* in pictures, as gnuplot takes it */
    const char *about;  /* its place, in a sentence or two */
    const char *note;   /* why it is not quite the case's problem, for its verdicts; NULL: it is */
    bool on_surface;
    bool has_force; /* false: what it says about forces is another's doing */
    bool has_scale;
    int32_t free_count;
    ss_accuracy_free free[SS_ACCURACY_MAX_FREE];
    const char *material[3]; /* its own names of linear, stvk, nh; NULL: takes none */
    /* The lines under `model:`. */
    void (*write)(FILE *file, const struct ss_model_class *class, const ss_accuracy_knobs *knobs);
    /* The lowest frequency (1/s) that follows from the parameters; NULL: to be measured. */
    double (*omega)(const ss_accuracy_knobs *knobs);
} ss_accuracy_model;

/* NULL: no row. */
const ss_accuracy_model *ss_accuracy_model_find(const char *name);
/* Has it physical parameters of its own, so that nothing is fitted? */
bool ss_accuracy_model_is_physical(const ss_accuracy_model *model);
/* The model's name of a case's material. */
const char *ss_accuracy_model_material(const ss_accuracy_model *model, const char *material);
ss_accuracy_body ss_accuracy_body_of(const ss_case *c, const ss_mesh *mesh);
/* The lines as a text, to be freed; NULL when out of memory. */
char *ss_accuracy_model_text(const ss_accuracy_model *model, const ss_accuracy_knobs *knobs);
/* May `key`, without what is after its '=', be set: a parameter of a physical model that the case
 * does not give. */
bool ss_accuracy_model_takes(const ss_accuracy_model *model, const char *key);
