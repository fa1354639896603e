/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the parts of the report on Zhang et al. (2018) share. Thread: main.
 *
 * The plane is the paper's: 21 x 21 nodes, h = 1 m apart, its rim fixed, its middle node pushed
 * along -z; C = 1 s, k = 1 N/m, so that figures are those of the network in its own units.
 */
#include "bench/papers/paper.h"
#include "bench/papers/zhang2018/reference.h"
#include "bench/papers/zhang2018/run.h"

enum {
    SS_PLANE_SIDE = 21,
    SS_PLANE_NODES = SS_PLANE_SIDE * SS_PLANE_SIDE,
    SS_PLANE_MIDDLE = SS_PLANE_NODES / 2
};

typedef struct ss_zhang_plane {
    ss_mesh *mesh;
    uint8_t fixed[SS_PLANE_NODES];
    int32_t pushed[1];
} ss_zhang_plane;

/* A volume with its support, patch of contact, and what else is asked of it again and again. */
typedef struct ss_zhang_solid {
    ss_mesh *mesh;
    uint8_t *fixed;
    double *volume;  /* m^3 a node */
    int32_t *pushed; /* the patch */
    int32_t pushed_count;
    double direction[3]; /* of the push */
    double mean_length;  /* m, of the edges of its tetrahedra */
} ss_zhang_solid;

typedef struct ss_zhang {
    ss_paper *paper;
    ss_zhang_plane plane;
    bool has_network; /* cnn-chainmail is built in */
} ss_zhang;

/* ---- bodies.c ---- */

softsim_status ss_zhang_plane_init(ss_zhang_plane *plane, softsim_error *error);
void ss_zhang_plane_fini(ss_zhang_plane *plane);
/* A setup on it: its middle pushed down. */
ss_zhang_setup ss_zhang_plane_setup(ss_zhang_plane *plane, const char *model, double depth,
                                    double step_s);
/* The report's reference network of it, alpha 0.02; stiffness_of NULL: 1 N/m. SOFTSIM_ERROR_MEMORY.
 */
softsim_status ss_zhang_plane_reference(const ss_zhang_plane *plane, ss_zhang_rule rule,
                                        const double *stiffness_of, ss_zhang_reference *out,
                                        softsim_error *error);
/* softsim-mesh generate SHAPE --tetrahedra with so many points; supports and patch are chosen by
 * the two functions below. */
softsim_status ss_zhang_solid_make(const ss_paper *paper, const char *shape, int32_t points,
                                   ss_zhang_solid *out, softsim_error *error);
void ss_zhang_solid_fini(ss_zhang_solid *solid);
/* The paper's liver of 5762 points, held where softsim-mesh says ("fixed"), with a patch of 15
 * nodes on the middle of its upper side. */
softsim_status ss_zhang_liver_make(const ss_paper *paper, ss_zhang_solid *out,
                                   softsim_error *error);
/* The patch: the `count` free surface nodes nearest to where the ray from `from` along `towards`
 * passes furthest out, pushed against it. SOFTSIM_ERROR_MEMORY. */
softsim_status ss_zhang_solid_patch(ss_zhang_solid *solid, const double from[3],
                                    const double towards[3], int32_t count, softsim_error *error);
/* The report's reference network of it, k 100 N/m, C 1 s. SOFTSIM_ERROR_MEMORY. */
softsim_status ss_zhang_solid_reference(const ss_zhang_solid *solid, double alpha,
                                        ss_zhang_rule rule, ss_zhang_reference *out,
                                        softsim_error *error);
/* A setup on it. */
ss_zhang_setup ss_zhang_solid_setup(const ss_zhang_solid *solid, const char *model, double depth);
/* Its surface displaced by u, seen from two sides. */
softsim_status ss_zhang_solid_draw(ss_paper *paper, const ss_zhang_solid *solid,
                                   const double (*u)[3], const char *name, const char *caption,
                                   softsim_error *error);

/* ---- sections ---- */

softsim_status ss_zhang_shapes(ss_paper *paper, softsim_error *error);     /* Fig. 4 */
softsim_status ss_zhang_forces(ss_paper *paper, softsim_error *error);     /* Fig. 5a */
softsim_status ss_zhang_hysteresis(ss_paper *paper, softsim_error *error); /* Fig. 5b */
softsim_status ss_zhang_relaxation(ss_paper *paper, softsim_error *error); /* Fig. 5c */
softsim_status ss_zhang_liver(ss_paper *paper, softsim_error *error);      /* Fig. 6 */
softsim_status ss_zhang_tissue(ss_paper *paper, softsim_error *error);     /* two tissues */
softsim_status ss_zhang_cells(ss_paper *paper, softsim_error *error);      /* future work */
softsim_status ss_zhang_fitting(ss_paper *paper, softsim_error *error);    /* future work */
softsim_status ss_zhang_speed(ss_paper *paper, softsim_error *error);
