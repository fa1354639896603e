/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the parts of the report on Zhong et al. (2006) share: the cylinder of 360 points, as a
 * rectangular grid and as triangles, in the program (a scene) and in the report's reference
 * network.
 *
 * Cylinder: 15 rings of 24 points, radius 1 m, length 4 m, axis z, end rings fixed. Point
 * ring * 24 + column stands at (sin a, cos a, z), a = 2 pi column / 24: the contact is column 0 of
 * the middle ring, pushed along -y. The program may number its nodes otherwise; they are found by
 * place. Working set: E 60 N/m, rho 0.05, and a node has 1 kg, gamma, ks 0.1 N/m.
 * Thread: main.
 */
#include "bench/papers/paper.h"
#include "bench/papers/zhong2006/motion.h"
#include "bench/papers/zhong2006/net.h"

enum {
    SS_TUBE_ROWS = 15,
    SS_TUBE_COLUMNS = 24,
    SS_TUBE_POINTS = SS_TUBE_ROWS * SS_TUBE_COLUMNS,
    SS_TUBE_TRIANGLES = 2 * (SS_TUBE_ROWS - 1) * SS_TUBE_COLUMNS,
    SS_TUBE_CONTACT = 7 * SS_TUBE_COLUMNS,
    SS_TUBE_LEFT = SS_TUBE_CONTACT + 6, /* of the contact's ring, at +x and -x */
    SS_TUBE_RIGHT = SS_TUBE_CONTACT + 18,
    SS_TUBE_MAX_LOADS = 12
};
#define SS_TUBE_MODULUS 60.0
#define SS_TUBE_RHO     0.05
#define SS_TUBE_KS      0.1

typedef struct ss_tube {
    const char *name; /* in claims: "grid", "triangles" */
    bool is_grid, is_there;
    char reason[256]; /* why it is not there */
    double position[SS_TUBE_POINTS][3];
    int32_t triangle[SS_TUBE_TRIANGLES][3]; /* of points; of grids too, for pictures */
    int32_t node[SS_TUBE_POINTS];           /* the program's number of a point */
    ss_trial_body body;
    char fixed[1024]; /* YAML */
} ss_tube;

typedef struct ss_tube_load {
    int32_t point;
    int32_t count;     /* of points along the axis around it that share the force; 0: it alone */
    double force;      /* N along -y */
    double from, ramp; /* s */
} ss_tube_load;

typedef struct ss_tube_setup {
    double gamma;             /* N s/m a node */
    const double *rho;        /* a point; NULL: 0.05 */
    double across;            /* rho around over rho along; 0: isotropic */
    double rho_along;         /* of anisotropic material */
    double saturation;        /* K; 0: none */
    bool is_per_area;         /* mass, damping and ks as densities with the same mean */
    double mean_area;         /* m^2, for densities */
    int32_t relaxation_steps; /* 0: equilibrium */
    ss_tube_load load[SS_TUBE_MAX_LOADS];
    int32_t load_count;
    double step_s;
} ss_tube_setup;

typedef struct ss_zhong {
    ss_paper *paper;
    ss_tube tube[2]; /* rectangular grid, triangles */
} ss_zhong;

/* ---- tube.c ---- */

/* Points, and the program's body where it can make one. `is_one_way`: all diagonals run one way. */
softsim_status ss_tube_init(const ss_paper *paper, bool is_grid, bool is_one_way, ss_tube *out_tube,
                            softsim_error *error);
void ss_tube_fini(ss_tube *tube);
softsim_status ss_tube_begin(const ss_paper *paper, const ss_tube *tube, const ss_tube_setup *setup,
                             ss_trial *out_trial, softsim_error *error);
/* Depth of the contact, width of its ring (2 at rest), m. */
double ss_tube_depth(const ss_tube *tube, const ss_trial *trial);
double ss_tube_width(const ss_tube *tube, const ss_trial *trial);
/* Displacements of the points. */
void ss_tube_points(const ss_tube *tube, const ss_trial *trial, double (*out_u)[3]);
/* The static shape under the setup's loads; out_u may be NULL. A refusal gives NaN and is told to
 * the page as `what`. */
softsim_status ss_tube_static(ss_paper *paper, const ss_tube *tube, const ss_tube_setup *setup,
                              const char *what, double *out_depth, double *out_width,
                              double (*out_u)[3], softsim_error *error);
/* The report's reference network of the same cylinder, source at the contact, solved; NULL when out
 * of memory. `rho` and `across` as in a setup. */
ss_zhong_net *ss_tube_net(const ss_tube *tube, const double *rho, double across);
/* Its static depth (and ring width, may be NULL) under a force on the contact; ks of a point is
 * stiffness[i] or, with NULL, 0.1. */
double ss_tube_net_static(ss_zhong_net *net, double force, const double *stiffness,
                          double *out_width);

/* ---- literal.c ---- */

typedef struct ss_zhong_outcome {
    double loaded;   /* m: depth at the end of the load */
    double left;     /* share of it at the end of the run */
    double shortest; /* edge over its length at rest, least of the run */
} ss_zhong_outcome;

/* Loads the contact of the reference network for 50 s and leaves it alone for left_s, with a row
 * reading,force_n,time_s,u_m,shortest_edge a sample. */
softsim_status ss_zhong_load_and_leave(const ss_zhong_net *net, const ss_tube *tube,
                                       const ss_zhong_law *law, const char *name, double force,
                                       double left_s, FILE *csv, ss_zhong_outcome *out,
                                       softsim_error *error);

/* ---- sections ---- */

softsim_status ss_zhong_creep(ss_paper *paper, softsim_error *error);       /* Fig. 4 */
softsim_status ss_zhong_hysteresis(ss_paper *paper, softsim_error *error);  /* Fig. 5 */
softsim_status ss_zhong_load_curves(ss_paper *paper, softsim_error *error); /* Fig. 6 */
softsim_status ss_zhong_materials(ss_paper *paper, softsim_error *error);   /* Figs. 7 to 11 */
softsim_status ss_zhong_kidney(ss_paper *paper, softsim_error *error);      /* Figs. 12, 13 */
softsim_status ss_zhong_rates(ss_paper *paper, softsim_error *error);       /* Table 1 */
softsim_status ss_zhong_organs(ss_paper *paper, softsim_error *error);
softsim_status ss_zhong_volume(ss_paper *paper, softsim_error *error); /* conclusion */
softsim_status ss_zhong_invariants(ss_paper *paper, softsim_error *error);
softsim_status ss_zhong_templates(ss_paper *paper, softsim_error *error);  /* eqs. 14 to 18, 26 */
softsim_status ss_zhong_relaxation(ss_paper *paper, softsim_error *error); /* eqs. 1, 2, 19, 20 */
softsim_status ss_zhong_literal(ss_paper *paper, softsim_error *error);    /* eqs. 3, 4, 26, 28 */
softsim_status ss_zhong_density(ss_paper *paper, softsim_error *error);    /* eqs. 5 to 9 */
