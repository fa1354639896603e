/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A volume of ten-node tetrahedra as an elastic body: mesh, masses, forces, stable step. Private to
 * `fem-quadratic`; the method stands in fem_quadratic.c.
 *
 * raise.c makes the mesh with a node on every edge out of the scene's, and the plan that speaks of
 * it; blocks.c lays the elements out for kernels.c; mass.c has masses and how much of them is added
 * for the sake of the step; skin.c the surface that tools touch; stability.c the stable step.
 * Memory: in the arena given. Thread: what creates, set-up only; the rest by the simulation thread,
 * RT-safe and deterministic.
 */
#include "models/common/body.h"
#include "models/common/fem_elastic.h"
#include "models/fem_quadratic/kernels.h"

/* Sub-steps take this share of the stable step. */
#define SS_QUADRATIC_STEP_SHARE 0.85

/* ---- raise.c ---- */

/* Of the longest edge, or of its own: a middle that is nearer to the straight one is on it. */
#define SS_QUADRATIC_STRAIGHT 1e-9

/* The scene's plan in terms of the raised mesh: its nodes are the given mesh's and then, where that
 * is of first order, one for each edge of a tetrahedron; each triangle of its surface is one of the
 * four into which the middles of its edges cut a face (the i-th into 4i .. 4i + 3, the one in the
 * middle last); tetrahedra are the given mesh's, by their corners. */
typedef struct ss_quadratic_raised {
    ss_mesh mesh;
    ss_model_plan plan;
    int32_t (*node)[SS_QUADRATIC_NODES]; /* of each tetrahedron, in the order of kernels.h */
    int32_t given_count;                 /* nodes of the given mesh */
    bool is_second_order;                /* that one is */
    int32_t curved_edge_count, straightened_edge_count;
    int32_t lost_edge_count; /* edges of the surface that the finer one is nowhere near */
} ss_quadratic_raised;

/* A node that is added is held, loaded or prescribed where both ends of its edge are and the edge
 * lies on the surface, or where a whole tetrahedron around it is; what is prescribed there is the
 * smooth field through the nodes around it. `is_curved`: edges go through the middles of a mesh of
 * second order; else those of the surface follow the plan's finer one, or its own normals. */
softsim_status ss_quadratic_raise(const ss_model_plan *plan, bool is_curved, ss_arena *arena,
                                  ss_quadratic_raised *out, softsim_error *error);

/* ---- surface.c ---- */

/* Moves each of `count` points, the straight middles of edges of `length` m, to the nearest point
 * of `surface`; one that has none within half of that stays, and is counted. False: out of memory.
 */
bool ss_quadratic_follow(const ss_mesh *surface, int32_t count, const double *length,
                         double (*position)[3], int32_t *out_lost);

/* ---- blocks.c ---- */

/* The rest map at a Gauss point. */
typedef struct ss_quadratic_point {
    double gradient[4][3]; /* of the barycentric coordinates, 1/m */
    double volume;         /* m^3, what the point stands for */
} ss_quadratic_point;

/* The four points of the element with these nodes; true where its edges are straight. */
bool ss_quadratic_points(const ss_mesh *mesh, const int32_t node[SS_QUADRATIC_NODES],
                         ss_quadratic_point out[SS_QUADRATIC_POINTS]);
/* Gradients of the ten shape functions at Gauss point q. */
void ss_quadratic_shape(const ss_quadratic_point *point, int q, double out[SS_QUADRATIC_NODES][3]);

/* In the order of kernels.h, but for `light`; false when out of memory. */
bool ss_quadratic_blocks_create(const ss_quadratic_raised *raised, const ss_fem_material *material,
                                ss_arena *arena, ss_quadratic_blocks *out);

/* ---- mass.c ---- */

typedef struct ss_quadratic_masses {
    double *mass;       /* kg, of every node of the raised mesh */
    double *added;      /* kg of it that was added, and has no weight */
    double bound;       /* 1/s^2, the largest omega^2 of an element: none of the body's is larger */
    double plain_bound; /* the same before mass was added */
    double added_share; /* of the whole mass */
    int32_t scaled_count;
} ss_quadratic_masses;

/* Adds at most `most` of the whole mass to the elements with the shortest step; sets `light`, in
 * units of the bound. */
softsim_status ss_quadratic_masses_create(const ss_quadratic_raised *raised,
                                          const ss_fem_material *material, double most,
                                          ss_quadratic_blocks *blocks, ss_arena *arena,
                                          ss_quadratic_masses *out);

/* ---- skin.c ---- */

/* Each curved face in sixteen flat parts, whose corners ride on the face's nodes. */
typedef struct ss_quadratic_skin {
    const ss_quadratic_raised *raised;
    ss_mesh mesh;
    int32_t *first, *node; /* row s: node[first[s]] .. node[first[s + 1] - 1] */
    ss_real *weight;
    double sigma;                     /* kg/m^2, of the nodes that carry it */
    double edge;                      /* m, mean */
    double reach[SOFTSIM_MAX_PROBES]; /* m, from a tool's middle: skin that is laid each time */
    int32_t *close, close_count;      /* that skin */
    bool is_all_due;
    double *load, *swing; /* scratch; load is clear between calls */
} ss_quadratic_skin;

softsim_status ss_quadratic_skin_create(const ss_quadratic_raised *raised, const double *mass,
                                        ss_arena *arena, ss_quadratic_skin *out);
/* What is near a tool at displacements u; NULL, NULL: all. Once an outer step, before it. */
void ss_quadratic_skin_list(ss_quadratic_skin *skin, const ss_real *u,
                            const ss_model_tool tool[SOFTSIM_MAX_PROBES]);
/* What ss_body_skin asks for; `owner` is the ss_quadratic. */
void ss_quadratic_skin_lay(void *owner, const ss_real *u, ss_real *skin_u);
void ss_quadratic_skin_carry(void *owner, int32_t count, const int32_t *node,
                             const ss_real *skin_force, ss_real *force);
void ss_quadratic_skin_carry_diagonal(void *owner, int32_t count, const int32_t *node,
                                      const double *stiffness, double *diagonal);
double ss_quadratic_skin_rate2(void *owner, int32_t count, const int32_t *node,
                               const double *stiffness, const ss_real *mobility);

/* ---- stability.c ---- */

typedef struct ss_quadratic_stability {
    double bound;              /* 1/s^2, of any element at rest */
    double rest_rate2;         /* omega_max^2 at rest, from above, 1/s^2 */
    double slack;              /* omega_max^2 over the largest omega_e^2 is taken to be no more */
    ss_real *mobility;         /* quads, 1/kg */
    ss_real *mode, *rest_mode; /* [block][10][3][8]: each element's fastest motion */
    ss_real *rate;    /* [block][8]: omega_e^2 over `bound`, of the state at the last look */
    ss_real *strains; /* [block][8]: |2E|^2 of the last force, and at the last look */
    ss_real *seen;
    ss_real *ratio;       /* [block][8]: scratch */
    int32_t *block;       /* list: scratch */
    double rate2;         /* of the state at the last look, from above */
    double certain_rate2; /* by its elements, as last looked at; 0 at first */
    double strain;        /* largest |2E| since stable_step was called last */
    int32_t turn;
    int32_t squeezed, inverted, worst;
} ss_quadratic_stability;

typedef struct ss_quadratic {
    const ss_quadratic_kernels *kernels;
    ss_quadratic_blocks blocks;
    ss_quadratic_masses masses;
    ss_quadratic_stability stability;
    ss_tissue_kind kind;
    ss_body_integrator integrator;
    double viscous_time, mass_damping; /* s, 1/s */
    double *diagonal;                  /* N/m, a node's mean at rest */
    const ss_real *u;                  /* of the last force */
    ss_quadratic_skin *skin;           /* the owner's; NULL without tools */
} ss_quadratic;

/* `most`: see ss_quadratic_masses_create. */
softsim_status ss_quadratic_create(const ss_quadratic_raised *raised,
                                   const ss_fem_material *material, double most, ss_arena *arena,
                                   ss_quadratic *out);
/* s, at rest. */
double ss_quadratic_rest_step(const ss_quadratic *quadratic);
/* What ss_body_elastic asks for; `owner` is the ss_quadratic. */
void ss_quadratic_force(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                        ss_body_energy *out);
void ss_quadratic_tangent(void *owner, const ss_real *x, ss_real *out);
void ss_quadratic_diagonal(void *owner, double *diagonal);
double ss_quadratic_stable_step(void *owner, const ss_body *body);
void ss_quadratic_reset(void *owner);
uint64_t ss_quadratic_hash(const void *owner, uint64_t seed);
/* Says so to the body where elements are squeezed or turned inside out; after stable_step. */
void ss_quadratic_judge(const ss_quadratic *quadratic, ss_body *body);
