/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * One run of a model for the report on Zhang et al. (2018): a body, supports, and a patch of
 * contact cells that goes in and out as the report says, step by step.
 *
 * The model is stepped by itself, through the interface that the world uses, since a scene's
 * prescribed displacement only goes in. The patch is a prescribed set with a ramp of one second,
 * and the time that the model is told is the share of the way: told to go back in time, the patch
 * goes back. A step is what the model calls stable, so that only one in which the patch goes
 * further than a quarter of a link is divided. Lengths are in m, C in s, forces in N. Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"
#include "softsim/types.h"

enum { SS_ZHANG_MAX_PARAM = 12 };

typedef struct ss_zhang_setup {
    const char *model;
    const char *param[SS_ZHANG_MAX_PARAM]; /* "alpha=0.02", "unloading=keep"; NULL ends them */
    double *stiffness_of;                  /* N/m: link stiffness by node; NULL: as in param */
    const ss_mesh *mesh;
    const uint8_t *fixed; /* node_count: 7 fixed, 0 free */
    int32_t *pushed;      /* the patch */
    int32_t pushed_count;
    double direction[3]; /* of the push, a unit vector */
    double depth;        /* m: as far as it goes */
    double step_s; /* that the model is made for; 0: what it then calls stable, with C given */
} ss_zhang_setup;

typedef struct ss_zhang_run {
    const ss_zhang_setup *setup;
    /* As models/model.h has them, whose shapes of tools are not the shapes of pictures. */
    const struct ss_model_class *class;
    struct ss_model *model; /* NULL when refused */
    char reason[256];
    struct ss_param_value *param;
    struct ss_prescribed *set;
    double step_s;           /* of a step */
    int32_t substeps;        /* of the last step */
    double depth;            /* m, now */
    double peak_energy_rise; /* J: the largest rise of the elastic energy in a step without work */
} ss_zhang_run;

/* Is the model built into this program? */
bool ss_zhang_has(const char *model);
/* A refusal, also of a model that is not built in, is no error: model is then NULL. */
softsim_status ss_zhang_begin(const ss_zhang_setup *setup, ss_zhang_run *out_run,
                              softsim_error *error);
/* One step, in which the patch goes to `depth`. */
void ss_zhang_step(ss_zhang_run *run, double depth);
/* Goes to `depth` at `speed` (m/s), a step at a time; or holds for `time_s`. SOFTSIM_ERROR_SYSTEM
 * when the program is stopped. */
softsim_status ss_zhang_go(ss_zhang_run *run, double depth, double speed, softsim_error *error);
softsim_status ss_zhang_hold(ss_zhang_run *run, double time_s, softsim_error *error);
/* The patch's resistance along the push, N. */
double ss_zhang_force(const ss_zhang_run *run);
/* Elastic energy, J. */
double ss_zhang_energy(const ss_zhang_run *run);
/* Displacements, node_count triples. */
void ss_zhang_read(const ss_zhang_run *run, double (*out_u)[3]);
void ss_zhang_end(ss_zhang_run *run);

/* ---- measures ---- */

/* sqrt(sum w |u - v|^2 / sum w |v|^2); w NULL: equal weights. */
double ss_zhang_distance(int32_t count, const double (*u)[3], const double (*v)[3],
                         const double *w);
/* A quarter of the volume of the tetrahedra around each node, m^3. */
void ss_zhang_volumes(const ss_mesh *mesh, double *out_volume);
int32_t ss_zhang_inverted(const ss_mesh *mesh, const double (*u)[3]);
/* sqrt of the mean over free nodes of |u_i - mean of the nodes of its elements|^2, m. NaN when out
 * of memory. */
double ss_zhang_roughness(const ss_mesh *mesh, const uint8_t *fixed, const double (*u)[3]);
