/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What every Newtonian model shares: a body of point masses on which elastic forces, loads,
 * prescribed axes and tools act, m u'' + alpha m u' = f_elastic(u, u') + f_loads + f_contact, with
 * the bookkeeping that says what was done to it.
 *
 * In: the scene's plan, masses, and the elastic law as a few functions. Out: everything that
 * ss_model_class asks for. A model keeps an ss_body as the first member of its struct, fills
 * ss_body_elastic, and has SS_BODY_STATE in its class; step, info where it has nothing to add.
 * Explicit models name an integrator; implicit and position-based ones give `advance` and call the
 * pieces (ss_body_external, ss_body_contact_diagonal) themselves. body_step.c derives the energy
 * balance, body_felt.c the stiffness that a tool feels.
 *
 * Nodes: the mesh's, then any of the model's own (particles). Arrays of nodes have 4 ss_real each,
 * x y z 0, on 64 bytes, their count padded to a multiple of 8 nodes with zeros.
 * Memory: all of it is allocated by ss_body_create. Thread: create, destroy, explain set-up only;
 * the rest by the simulation thread, RT-safe and deterministic.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "models/common/inverted.h"
#include "models/model.h"

typedef struct ss_body ss_body;

/* What an evaluation of the elastic forces is asked for beside them. */
typedef struct ss_body_energy {
    bool is_wanted; /* `elastic` is asked for; `power` always, where there is viscosity */
    double elastic; /* J stored at (u, v) */
    double power;   /* W dissipated at (u, v), >= 0; the mass damping is the body's own */
    bool elastic_is_upper_bound; /* out: `elastic` may be more than the motion has put in, since the
                      model's step is softer than its law: gains are then judged by kinetic energy
                      alone */
} ss_body_energy;

/* The model's part; every function gets `owner` and must be RT-safe. */
typedef struct ss_body_elastic {
    void *owner;
    /* Adds the elastic and viscous forces at displacements u and velocities v to `force`, also at
     * fixed nodes (their reactions). */
    void (*force)(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                  ss_body_energy *out);
    /* Adds K x to `out`, K the symmetric static tangent at the last `force` (or at rest, if that
     * is stiffer everywhere that matters): what the hand's stiffness is estimated from. */
    void (*tangent)(void *owner, const ss_real *x, ss_real *out);
    /* Adds about the mean diagonal of K (N/m) of each node: a preconditioner, so rest will do. */
    void (*diagonal)(void *owner, double *diagonal);
    /* The elastic step bound at the present state for the chosen integrator, in s, contact left
     * out: 2/omega, viscosity included, for the symplectic Euler method. Called once an outer step
     * with the state (u, v) of the body. INFINITY for models that are stable at any step. */
    double (*stable_step)(void *owner, const ss_body *body);
    /* A sub-step of `h` seconds, from (u, v) of the body to its new (u, v), by the model itself;
     * NULL: the integrator of the plan. The tools end at `path_end` of their way; ss_body_external
     * gives their forces and the loads at any u. Prescribed axes are already moved to their end
     * place and have their constant velocity; axes whose mobility is 0 must be left alone. */
    void (*advance)(void *owner, ss_body *body, double h, double path_end);
    /* After each accepted sub-step (NULL: nothing): activation and the like. */
    void (*after_substep)(void *owner, ss_body *body, double h);
    /* Back to rest (NULL: nothing to do): whatever of the model is state beside (u, v). */
    void (*reset)(void *owner);
    /* As of ss_model_class (NULL: nothing). */
    void (*slept)(void *owner, int64_t steps);
    /* FNV-1a of that state (NULL: none). */
    uint64_t (*hash)(const void *owner, uint64_t seed);
    /* s, viscosity over stiffness: motions y meet y.C y = viscous_time y.K y; 0 without. */
    double viscous_time;
} ss_body_elastic;
/* What every model gives; the rest is named beside it. */
#define SS_BODY_ELASTIC(of, its_force, its_tangent, its_diagonal, its_stable_step)                 \
    .owner = (of), .force = (its_force), .tangent = (its_tangent), .diagonal = (its_diagonal),     \
    .stable_step = (its_stable_step)

/* A surface that rides on the nodes and takes the contact in their place (NULL mesh: the contact
 * acts on the surface of the plan's mesh, whose nodes are the first of the body's). */
typedef struct ss_body_skin {
    const ss_mesh *mesh; /* borrowed */
    double sigma;        /* kg/m^2, least mass per area of what carries it: bounds the stiffness */
    /* Displacements of all skin nodes (4 ss_real each) from those of the body's. */
    void (*lay)(void *owner, const ss_real *u, ss_real *skin_u);
    /* Adds what the forces on skin nodes `node[0..count)` give the body's nodes: the transpose. */
    void (*carry)(void *owner, int32_t count, const int32_t *node, const ss_real *skin_force,
                  ss_real *force);
    /* Adds an upper bound of S^T diag(skin) S's row sums to `diagonal` (N/m). */
    void (*carry_diagonal)(void *owner, int32_t count, const int32_t *node, const double *skin,
                           double *diagonal);
    /* An upper bound of the largest eigenvalue of M^-1 S^T diag(skin) S, 1/s^2; `skin` is 0 but at
     * node[0..count), each once, and `mobility` is ss_body_nodes'. */
    double (*rate2)(void *owner, int32_t count, const int32_t *node, const double *skin,
                    const ss_real *mobility);
} ss_body_skin;

typedef enum ss_body_integrator { SS_BODY_SYMPLECTIC_EULER, SS_BODY_RK4 } ss_body_integrator;

typedef struct ss_body_plan {
    const char *name;          /* the model's, for messages; static */
    const ss_model_plan *plan; /* copied; what it points to outlives the body, but `param` */
    int32_t node_count;        /* the mesh's, and the model's own after them */
    const double *mass;        /* kg, node_count; copied. 0: a node that nothing moves */
    const double *unweighed;   /* kg, node_count: mass without weight, added for the sake of the
                                  step; NULL: none. Outlives the body */
    double mass_damping;       /* alpha, 1/s */
    double edge;               /* m, typical edge: a node moves at most 0.2 of it a sub-step */
    double planned_step;       /* s, the sub-step meant at rest: the contact's stiffness is chosen
                                  by it. 0: what the stable step at rest asks for (usual);
                                  INFINITY: the model takes contact implicitly */
    double step_share;         /* of the stable step that sub-steps take, e.g. 0.5 */
    double contact_share;      /* the same of the contact's part of it; 0: step_share */
    ss_body_integrator integrator; /* of models without `advance` */
    bool is_grounded; /* its own law holds the body where it is: it needs no supports */
    ss_body_elastic elastic;
    ss_body_skin skin;
    /* Prescribed sets and loads act on mesh nodes with a mass; name them otherwise. */
} ss_body_plan;

/* The state, open to the model's kernels. Read-only but where a function says otherwise. */
typedef struct ss_body_nodes {
    int32_t count, padded_count;
    double origin[3];  /* m, world: rest positions are from here, so that offsets cost nothing */
    double (*rest)[3]; /* m, from `origin`, of the mesh's nodes; the model's own are 0 */
    ss_real *u, *v;    /* m, m/s; `advance` writes them */
    ss_real *force;    /* N, all of it, at the last evaluation */
    ss_real *mobility; /* 1/kg by axis: 0 where fixed or prescribed, or without mass */
    double *mass;      /* kg; changed by ss_body_set_mass alone */
    double kick_lag;   /* s by which v is behind u: half a sub-step with the symplectic Euler
                          method, else 0 */
} ss_body_nodes;

/* Faults of fixed nodes, loads, prescribed sets and tools against the mesh and the masses are all
 * named in `error`; *out_body is NULL then. Thread: set-up only. */
softsim_status ss_body_create(const ss_body_plan *plan, ss_body **out_body, softsim_error *error);
/* Calls the elastic functions for the first time: what contact is at rest, the stable step, and
 * reset. Once, when the owner is complete. Thread: set-up only. */
softsim_status ss_body_start(ss_body *body);
void ss_body_destroy(ss_body **body);
ss_body_nodes *ss_body_get_nodes(ss_body *body);
const ss_body_nodes *ss_body_read_nodes(const ss_body *body);

/* ---- masses (set-up) ---- */

/* density x a quarter of the tetrahedra's rest volumes; density: a value a node, element value is
 * the mean of its corners' (`per_element` false), or one an element. out: mesh->node_count. */
void ss_body_volume_masses(const ss_mesh *mesh, const double *density, bool per_element,
                           double *out_mass);
/* area density (kg/m^2, a value a node) x a third of the triangles' rest areas. */
void ss_body_area_masses(const ss_mesh *mesh, const double *density, double *out_mass);
/* Mean length of the edges of tetrahedra, else of triangles, m. */
double ss_body_mean_edge(const ss_mesh *mesh);
/* The mean side of its triangles, m. */
double ss_body_mean_side(const ss_mesh *mesh);
/* The largest stable step (s) of an explicit method for modes up to sqrt(rate2), 1/s^2, viscosity
 * viscous_time times the stiffness (lagged, as forces see v) and mass damping (1/s): 2/omega
 * (sqrt(1 + zeta^2) - zeta), zeta = viscous_time omega / 2; Runge-Kutta: within its region of
 * stability. INFINITY for rate2 = 0 without damping. */
double ss_body_step_limit(ss_body_integrator integrator, double rate2, double viscous_time,
                          double mass_damping);
/* Mass of one node from now on, with its momentum as it is told: for models that move mass. */
void ss_body_set_mass(ss_body *body, int32_t node, double mass);

/* ---- the class of a model ---- */
/* Functions of ss_model_class for any model whose struct begins with its `ss_body *`. */

void ss_body_model_step(ss_model *model, double time, double dt,
                        const ss_model_tool tool[SOFTSIM_MAX_PROBES]);
void ss_body_model_contacts(ss_model *model, int32_t probe, double near, ss_contact_set *out);
void ss_body_model_reset(ss_model *model);
void ss_body_model_info(const ss_model *model, ss_model_info *out);
const ss_real *ss_body_model_displacement(const ss_model *model);
const ss_real *ss_body_model_velocity(const ss_model *model);
void ss_body_model_reaction(const ss_model *model, int32_t set, double out_force[3]);
uint64_t ss_body_model_hash(const ss_model *model, uint64_t seed);
void ss_body_model_slept(ss_model *model, int64_t steps);

/* SS_MODEL_STATE of such a class, by what gives info, displacement and velocity: those above where
 * the model adds nothing to them (SS_BODY_MOTION are the last two). */
#define SS_BODY_STATE(info_of, ...)                                                                \
    SS_MODEL_STATE(ss_body_model_contacts, ss_body_model_reset, info_of, __VA_ARGS__,              \
                   ss_body_model_reaction, ss_body_model_hash),                                    \
        .takes_friction = true, .slept = ss_body_model_slept
#define SS_BODY_MOTION ss_body_model_displacement, ss_body_model_velocity

/* ---- the same of the body, for models that add to it ---- */

void ss_body_step(ss_body *body, double time, double dt,
                  const ss_model_tool tool[SOFTSIM_MAX_PROBES]);
void ss_body_contacts(ss_body *body, int32_t probe, double near, ss_contact_set *out);
void ss_body_info(const ss_body *body, ss_model_info *out);
void ss_body_reaction(const ss_body *body, int32_t set, double out_force[3]);
uint64_t ss_body_hash(const ss_body *body, uint64_t seed);
void ss_body_slept(ss_body *body, int64_t steps);
void ss_body_reset(ss_body *body);
/* Lines about masses, tools, contact stiffness, what is left out. Thread: set-up only. */
void ss_body_explain(const ss_body *body, const ss_notes *out);

/* ---- report of a model ---- */

/* Something acted: raises the verdict of the present step to at least `verdict` and sets its reason
 * (static text) and fault bits. */
void ss_body_judge(ss_body *body, softsim_verdict verdict, uint32_t fault_bits, const char *reason);
/* What is at fault or limits the step, a tetrahedron or a node as ss_model_info has it; -1 none. */
void ss_body_set_worst_element(ss_body *body, int32_t element);
void ss_body_set_active_nodes(ss_body *body, int32_t count);
/* Looks at a share of the tetrahedra, and says so while one is turned inside out: by its number, or
 * by a node of it. */
void ss_body_judge_inverted(ss_body *body, bool names_node);
/* The elastic law changed (`set`): what that adds to the stored energy is booked as work. */
void ss_body_renew(ss_body *body);

/* ---- pieces for models with `advance` ---- */

/* force := loads + contact + grasps at displacements u (4 ss_real a node) with the tools at `path`
 * (0..1) of their way through the outer step. Keeps the active contact samples for the two below.
 */
void ss_body_external(ss_body *body, const ss_real *u, double path);
/* Where the tools are on their way as the sub-step begins. Explicit forces of a contact are taken
 * there: with the tools ahead of the nodes, pressing and letting go would both gain energy. */
double ss_body_path_start(const ss_body *body);
/* Adds the contact's and grasps' stiffness to diagonal[i], N/m: rows of an upper bound. */
void ss_body_contact_diagonal(ss_body *body, double *diagonal);
/* out += K_contact x of the active samples and grasps: less their force's change for motions x. */
void ss_body_contact_tangent(ss_body *body, const ss_real *x, ss_real *out);
/* Is any tool in the world? Else ss_body_external is the loads. */
bool ss_body_has_contact(const ss_body *body);
double ss_body_mass_damping(const ss_body *body);
