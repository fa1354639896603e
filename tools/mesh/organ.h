/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What softsim-mesh scene has decided, and the parts that it is made by: organ_unit.c chooses the
 * unit, organ_held.c what is held, organ_text.c writes it as a scene, organ_picture.c draws it,
 * organ_report.c says how it is felt, scene.c decides the rest. SI, world frame.
 */
#include <stdio.h>

#include "contact/touch.h"
#include "models/model.h"
#include "tissue.h"
#include "trial.h"

/* In the order of --for. */
enum { ORGAN_FOR_FEEL, ORGAN_FOR_ACCURACY, ORGAN_FOR_SPEED };

/* What the user asked for. */
typedef struct organ_request {
    const char *mesh, *tissue_name, *out, *fixed, *model, *preview;
    int32_t units, purpose, side; /* -1: units were not given */
    double tool_mm;               /* 0: by the body's size */
    bool lists_tissues;
} organ_request;

/* A tool's radius over the mean edge, at least, unless another was asked for. */
#define ORGAN_RADIUS_PER_EDGE 1.1

typedef struct organ {
    const char *mesh_name; /* as the scene is to name the file */
    const char *unit;      /* of the file */
    char unit_words[160];  /* why */
    char unit_doubt[240];  /* "": none; it is no organ's size in the unit that was given */
    bool is_repaired;
    double low[3], high[3], diagonal, edge; /* of the surface: box, diagonal, mean edge */
    double volume, area;
    bool is_closed, has_volume, is_second_order;
    bool is_fanned; /* the contact surface refuses a node for its many triangles */
    int64_t open_edges, crossing_count;
    bool is_crossing_complete; /* every pair was looked at */
    int32_t part_count;

    const tissue *tissue;
    const ss_model_class *model;
    char passed_over[320]; /* models that were tried before it, and why not */
    double scale;          /* of all forces of a model whose constants are not physical */

    double towards[3]; /* the side that the hand comes from */
    const char *side, *axes;
    char fixed[2048];    /* the entries of object.fixed, a line each */
    double radius;       /* of the tool */
    double usual_radius; /* that the body's size alone would ask for */
    double depth;        /* at which the force is read */
    double deepest;      /* as deep as the simulated hand goes */
    double hand_scale;   /* world metres a metre of that hand */
    double working_force, max_force;
    double planned_max_force; /* that a model's contact may lower */

    /* Parts that the side away from the hand has nothing of: held by boxes, or too many for that.
     */
    int32_t boxed_count, loose_count;

    /* of the scene, once it is loaded */
    bool is_rounded; /* its corners are not where they are felt */
    int32_t node_count, tetrahedron_count, fixed_count;
    double stable_step_s, step_s, step_cost_us;
    ss_touch touch;
    double touch_gap; /* m: so much below the mesh what is felt begins there */
    trial_result trial;
} organ;

/* The unit of the mesh in `path`, `given` by its number or, -1, judged by its size; the positions
 * become metres. */
softsim_status organ_choose_unit(organ *o, const char *path, int32_t given, ss_mesh *mesh,
                                 softsim_error *error);

/* May it stand in a line of the scene? */
bool organ_is_text(const char *text);
/* From the side away from the hand to its own. */
double organ_height(const organ *o);
/* What is held, into o->fixed; an error: it was asked for in words of no meaning. */
softsim_status organ_choose_fixed(const organ_request *q, const ss_mesh *mesh, organ *o,
                                  softsim_error *error);

/* To two digits. */
double organ_round(double x);
/* The force of the press that was held, over Hertz's for the way that the surface went. */
double organ_ratio(const organ *o);
/* Are linear tetrahedra so much too stiff there that another model is better? */
bool organ_is_stiff(const organ *o);
/* Why a model of tetrahedra cannot have this surface, and the commands that fill it. */
softsim_status organ_refuse_surface(const organ_request *q, const organ *o, softsim_error *error);
/* Adds to the fault of a scene that could not be made what would make one, where that is known. */
void organ_advise(const organ_request *q, const organ *o, softsim_status status,
                  softsim_error *error);
/* Warnings, what was written and how it is felt, and what comes next. */
void organ_report(const organ_request *q, const organ *o);

/* The constants of the model, a line each as they stand under `model:`. */
void organ_write_model(FILE *out, const organ *o);
/* In the double quotes of YAML. */
void organ_write_quoted(FILE *out, const char *text);
/* The whole scene; `is_draft`: without what is known only once it was loaded and pressed. */
void organ_write(FILE *out, const organ *o, bool is_draft);

/* A picture of the body, what is held, the tool and the way of the press, by gnuplot. */
softsim_status organ_draw(const organ *o, const ss_touch_body *body, const char *path,
                          softsim_error *error);
