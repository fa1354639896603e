/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The report on the hybrid model's paper: its bodies, pressed and timed through the interface of
 * models. Units are the paper's, with m, kg and s beside them. Thread: main.
 */
#include "bench/papers/paper.h"
#include "models/model.h"

/* Table 1. */
typedef struct ss_heart_row {
    const char *name;
    double lambda, mu, viscosity, step;
} ss_heart_row;
enum { SS_HEART_ED0, SS_HEART_HM1, SS_HEART_HM2, SS_HEART_ROWS };
extern const ss_heart_row ss_heart_table[SS_HEART_ROWS];

enum { SS_HEART_PARAMETERS = 40 };

typedef struct ss_heart_body {
    ss_mesh *mesh;
    const char *model_name;
    uint8_t *fixed;
    ss_param_value param[SS_HEART_PARAMETERS];
    ss_model_plan plan;
    const ss_model_class *model_class;
    ss_model *model;
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    double time, step; /* s */
    softsim_verdict worst;
    char reason[96]; /* of the worst verdict */
} ss_heart_body;

/* Meshes by softsim-mesh generate; sizes in mm of a unit of 1000. NULL with a fault in `error`. */
ss_mesh *ss_heart_generate(const ss_paper *paper, const char *const *argv, softsim_error *error);
/* The ellipsoids 1, 0.8, 0.8 and 0.6, 0.45, 0.45 of about so many nodes; the ventricle HM2, and
 * HM1's core with the layer up to its outer wall. */
ss_mesh *ss_heart_ellipsoids(const ss_paper *paper, int32_t nodes, softsim_error *error);
ss_mesh *ss_heart_ventricle(const ss_paper *paper, softsim_error *error);
ss_mesh *ss_heart_layered(const ss_paper *paper, softsim_error *error);
/* The ellipsoids with a core of half the wall, the rest a layer. */
ss_mesh *ss_heart_layered_ellipsoids(const ss_paper *paper, softsim_error *error);

/* Takes the mesh; the row's material and step, mass damping 2, `group` fixed, a ball of 0.2. */
void ss_heart_init(ss_heart_body *body, ss_mesh *mesh, const char *model, const ss_heart_row *row,
                   const char *group);
/* A row of the model's table by its name. */
void ss_heart_set(ss_heart_body *body, const char *name, double value);
/* The layer's: m, m, particles. */
void ss_heart_set_layer(ss_heart_body *body, double spacing, double activate, double max_active);
softsim_status ss_heart_start(ss_heart_body *body, softsim_error *error);
void ss_heart_end(ss_heart_body *body);

/* The ball's centre moves in a straight line in `steps` steps, from where it was (the first time:
 * it appears there). Returns the median thread-CPU time of a step, us. */
double ss_heart_move(ss_heart_body *body, const double to[3], int32_t steps);
void ss_heart_idle(ss_heart_body *body, int32_t steps);
/* Force on the ball, N; how many particles are awake. */
void ss_heart_force(ss_heart_body *body, double out_force[3]);
int32_t ss_heart_awake(const ss_heart_body *body);

/* Sections of the page. */
softsim_status ss_heart_pair_curve(ss_paper *paper, softsim_error *error);
softsim_status ss_heart_steps(ss_paper *paper, softsim_error *error);
softsim_status ss_heart_rates(ss_paper *paper, softsim_error *error);
softsim_status ss_heart_speed(ss_paper *paper, softsim_error *error);
softsim_status ss_heart_indentation(ss_paper *paper, softsim_error *error);
softsim_status ss_heart_walls(ss_paper *paper, softsim_error *error);
softsim_status ss_heart_pictures(ss_paper *paper, softsim_error *error);
softsim_status ss_heart_literal(ss_paper *paper, softsim_error *error);
