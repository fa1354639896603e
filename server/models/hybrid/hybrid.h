/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside `hybrid`: its state, shared by hybrid.c (the model), volume.c (forces of the layer
 * and its share of the body), near.c (its rows where they are needed), wake.c (which
 * particles are awake) and bound.c (the stable step).
 *
 * Three kinds of particle. Awake: a node of its own. Near: tied to the core, but its stiffness is
 * the layer's, wholly or in part. Asleep: its stiffness and mass are the core's. Nodes of the
 * body: the mesh's (skin nodes have no mass and ride), then one place for each particle that can be
 * awake at once.
 * Thread: as model.h says.
 */
#include "models/common/body.h"
#include "models/common/fem_elastic.h"
#include "models/hybrid/layer_kernels.h"
#include "models/hybrid/point_grid.h"
#include "models/layer.h"

enum {
    SS_HYBRID_SPACING = SS_FEM_ROW_COUNT,
    SS_HYBRID_THICKNESS,
    SS_HYBRID_COHESION,
    SS_HYBRID_STABILISATION,
    SS_HYBRID_ACTIVATE,
    SS_HYBRID_DEACTIVATE,
    SS_HYBRID_MAX_ACTIVE,
    SS_HYBRID_ROW_COUNT
};

/* Of layer.max_active, where that is not all; the rest is for particles that may sleep but do not
 * yet. */
#define SS_HYBRID_FULL 0.85

typedef struct ss_hybrid_particle {
    int32_t point;           /* its place among the points; -1: its stiffness is all the core's */
    int32_t near;            /* its place among the near particles, -1 */
    int32_t wanted;          /* its place among the wanted ones, -1 */
    int32_t need;            /* points that it is or is a neighbour of */
    int32_t release_updates; /* changes until it sleeps wherever it is, once released */
    ss_real blend;           /* of its stiffness that is the layer's, 0..1 */
    ss_real target;          /* what blend goes to */
} ss_hybrid_particle;

/* A skin node that is not only tied to the core: theta of it follows the particles. */
typedef struct ss_hybrid_ride {
    ss_real theta;
    int32_t wanted; /* particles of its row that are wanted */
    bool is_old;    /* its particles have changed since the row was made */
    int32_t count;  /* of its row over nodes; 0: asleep */
    int32_t *node;  /* room for its particles and all nodes that they are tied to */
    ss_real *weight;
} ss_hybrid_ride;

typedef struct ss_hybrid {
    ss_body *body;    /* first, as ss_body_model_... take it */
    const ss_real *u; /* of the last force */
    ss_arena arena;
    const ss_mesh *mesh;
    ss_layer *layer;
    ss_fem_material material;
    const ss_fem_kernels *law;
    const ss_layer_kernels *kernels;

    /* parameters */
    double cohesion, stabilisation; /* chi, beta */
    double wake_reach, sleep_reach; /* m, from the tool's surface */
    int32_t max_awake, max_points;
    bool is_all_awake; /* reach beyond the body: nothing ever sleeps */
    bool is_locking;   /* fem would cure it by itself */

    /* core */
    ss_fem_blocks core;
    int32_t *lane;  /* by element: 8 block + lane */
    double *volume; /* m^3 that an element stands for: without what its ghosts may take */

    /* the sleeping layer */
    ss_layer_cells cells;
    ss_fem_blocks cell_blocks; /* the law's side of the cells */
    int32_t *cell_of;          /* by particle */
    double *cell_volume;       /* m^3 that a cell stands for now */
    double *cell_asleep;       /* and while all sleeps */
    double *mass_asleep;       /* kg, by node of the body: while all sleeps */
    double *cell_lambda, *cell_mu, *cell_phi, *cell_psi; /* Pa, Pa s */

    /* particles */
    ss_hybrid_particle *particle;
    int32_t *node_of; /* node of the body while awake, else -1 */
    uint8_t *is_held; /* particles under fixed skin, which stay tied */
    int32_t held_skin;
    uint8_t *fixed;  /* of mesh nodes, without the skin */
    ss_real *offset; /* quads, m: a tied particle that came to rest beside its tie */
    int32_t *point, point_count;
    ss_real *coefficient, *gradient, *spread, *stress; /* as ss_layer_pass has them */
    ss_fem_blocks points;                              /* the law's side of the points */
    int32_t *near, near_count;
    int32_t *wanted, wanted_count;
    int32_t *idle, idle_count;         /* nodes that no particle has */
    int32_t *drifting, drifting_count; /* particles with an offset */
    ss_layer_near near_rows;           /* the near ones side by side */
    bool is_near_old;                  /* one came or went since they were gathered */
    int32_t *place_of;                 /* by particle: its place among them, while it is near */
    ss_real *state, *particle_force;   /* as ss_layer_pass has them */
    int32_t awake_count;
    bool is_fading, is_skin_fading; /* a blend, a theta is not at its target */
    uint32_t step_counter;          /* outer steps since all slept */

    /* skin */
    int32_t *rider_first, *rider; /* by particle: places in the layer's skin rows that name it */
    ss_hybrid_ride *ride;         /* by skin node */
    int32_t *ride_node;           /* of all rides */
    ss_real *ride_weight;
    int32_t *riding, riding_count; /* skin nodes with a row */
    int32_t *riding_at;            /* by skin node: its place among them, -1 */
    int32_t *mark;                 /* by node of the body: scratch of a row, -1 between calls */
    double *span;                  /* m, by skin node: the longest edge of it and its neighbours */
    int32_t *close, close_count;   /* skin nodes that a tool may reach before the next list */
    int32_t *around, around_count; /* and that say where it would be at rest */
    double listed[SOFTSIM_MAX_PROBES][3]; /* m: tools at the last list */
    bool was_listed[SOFTSIM_MAX_PROBES];
    int32_t list_age;               /* outer steps */
    int32_t *core_node, core_count; /* mesh nodes that are no skin */
    int32_t lay_batch;              /* which sleeping skin nodes are laid next */
    bool is_batch_due;              /* they were not in this outer step */
    bool is_skin_old;               /* the body's copy is not `laid` but for what is laid next */
    ss_real *laid;                  /* quads of mesh nodes: as laid last */
    ss_real *shown, *shown_v;       /* quads of mesh nodes: what displacement() returns */
    double *load;                   /* by node of the body: scratch of a bound, 0 between calls */
    double *swing;                  /* by mesh node: scratch of a bound, anything between calls */

    /* where the tools are */
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    ss_tool_plan shape[SOFTSIM_MAX_PROBES];
    double close_reach[SOFTSIM_MAX_PROBES];  /* m: skin nearer to a tool's origin is always laid */
    double around_reach[SOFTSIM_MAX_PROBES]; /* m: and nearer than this says how it has moved */
    double scanned[SOFTSIM_MAX_PROBES][3];   /* m: middle of the tool at rest at the last scan */
    bool was_scanned[SOFTSIM_MAX_PROBES];
    ss_point_grid grid;              /* of own particles */
    double *distance;                /* by own particle: to the tools at the last scan, m */
    int32_t *found, found_count;     /* particles in reach at the last scan */
    double current_sleep_reach;      /* m: nearer ones were not released at the last look */
    double least_spacing, skin_edge; /* m; the edge is the mean one of the surface */

    /* step bound */
    ss_real *mode, *product;
    double rest_rate2; /* omega^2 of the stiffest motion at rest, from above, 1/s^2 */
    double rate2;      /* omega^2 of the stiffest motion, from above, 1/s^2 */
    double strain,
        strain_at_power_step; /* largest |2E| since the last bound, and at the last power step */
    int32_t age;
} ss_hybrid;

/* ---- volume.c ---- */

/* Forces, tangent and preconditioner of core and layer, as ss_body_elastic asks for them. */
void ss_hybrid_force(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                     ss_body_energy *out);
void ss_hybrid_tangent(void *owner, const ss_real *x, ss_real *out);
void ss_hybrid_diagonal(void *owner, double *diagonal);
/* After a change of cell_volume, of volume. */
void ss_hybrid_write_cell(ss_hybrid *hybrid, int32_t c);
void ss_hybrid_write_element(ss_hybrid *hybrid, int32_t e);
/* The blend that p would have with the whole layer awake: the layer's own 1, ghosts less. */
double ss_hybrid_full_blend(const ss_hybrid *hybrid, int32_t p);
/* The same with a neighbour of that weight awake, but none nearer. */
double ss_hybrid_blend_beside(double weight);
/* The fraction of particle p's stiffness that is the layer's; the rest is its cell's. */
void ss_hybrid_set_blend(ss_hybrid *hybrid, int32_t p, double blend);
/* Particle p becomes a point with blend 0, or stops being one; its neighbours are near then. */
void ss_hybrid_add_point(ss_hybrid *hybrid, int32_t p);
void ss_hybrid_remove_point(ss_hybrid *hybrid, int32_t p);
/* Displacement (or velocity) of a tied particle. */
void ss_hybrid_tied(const ss_hybrid *hybrid, int32_t p, const ss_real *u, double out[3]);

/* ---- cells.c ---- */

/* Cells and their blocks; false when out of memory. Thread: set-up only. */
bool ss_hybrid_create_cells(ss_hybrid *hybrid);
/* Blocks of `count` elements on three unit edges, nodes as ss_layer_pass numbers columns; empty. */
bool ss_hybrid_create_blocks(ss_hybrid *hybrid, int32_t count, ss_fem_blocks *out);

/* ---- near.c ---- */

/* Room for the near particles; false when out of memory. Thread: set-up only. */
bool ss_hybrid_create_near(ss_hybrid *hybrid);
/* Particle p, near or not, changed its node or its offset. */
void ss_hybrid_move_near(ss_hybrid *hybrid, int32_t p);
/* Brings near_rows up to date. */
void ss_hybrid_gather_near(ss_hybrid *hybrid);

/* ---- wake.c ---- */

/* No node of the body is a particle's. */
void ss_hybrid_idle_all(ss_hybrid *hybrid);
/* All asleep, or all awake where nothing sleeps. */
void ss_hybrid_reset_layer(ss_hybrid *hybrid);
/* How many are to be awake at once: all where there is room for all. */
double ss_hybrid_most_wanted(const ss_hybrid *hybrid);
/* Before every outer step; true when anything changed that forces depend on. */
bool ss_hybrid_wake(ss_hybrid *hybrid);
/* Wakes the up to max_awake particles nearest to skin node s, for measuring. */
void ss_hybrid_wake_around(ss_hybrid *hybrid, int32_t s);

/* ---- skin.c ---- */

/* Before every outer step: which of the skin is near the tools. */
void ss_hybrid_list_skin(ss_hybrid *hybrid);
/* As ss_body_skin asks for them. */
void ss_hybrid_lay(void *owner, const ss_real *u, ss_real *skin_u);
void ss_hybrid_carry(void *owner, int32_t count, const int32_t *node, const ss_real *skin_force,
                     ss_real *force);
void ss_hybrid_carry_diagonal(void *owner, int32_t count, const int32_t *node, const double *skin,
                              double *diagonal);
double ss_hybrid_carry_rate2(void *owner, int32_t count, const int32_t *node, const double *skin,
                             const ss_real *mobility);
/* Every node of the mesh, skin included, now. */
void ss_hybrid_show(const ss_hybrid *hybrid, const ss_real *u, ss_real *out);
/* Particle p woke (+1) or fell asleep (-1) or changed its node (0): before ss_hybrid_fade_skin. */
void ss_hybrid_tell_skin(ss_hybrid *hybrid, int32_t p, int change);
/* Rows follow their particles by `step` of the way; false when all were there already. */
bool ss_hybrid_fade_skin(ss_hybrid *hybrid, ss_real step);

/* ---- bound.c ---- */

/* omega^2 of the stiffest motion at the present state, from above, 1/s^2. */
double ss_hybrid_converge_rate(ss_hybrid *hybrid);
/* As before the first step. */
void ss_hybrid_forget(ss_hybrid *hybrid);
/* Fills rate2 from the stiffest motions asleep and awake. */
void ss_hybrid_measure(ss_hybrid *hybrid);
double ss_hybrid_stable_step(void *owner, const ss_body *body);

/* ---- explain.c ---- */

/* Of the stable step that sub-steps take. */
#define SS_HYBRID_STEP_SHARE 0.5
double ss_hybrid_step_cost_us(const ss_model_plan *plan);
void ss_hybrid_explain(const ss_model *model, const ss_notes *out);
