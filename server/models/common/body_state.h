/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the files of the body share: its state and its parts. Private to them; models use body.h.
 * Thread: as body.h says.
 */
#include "models/common/body.h"
#include "models/common/loads.h"
#include "models/common/plan.h"
#include "models/common/tools.h"

/* How stiff a tool feels the body, kept from step to step. */
typedef struct ss_body_touch {
    ss_real *shape_y;    /* motion of the nodes per unit motion of the tool along its push, */
    ss_real *shape_step; /* and how it was last improved */
    int32_t age;         /* calls since the estimate was last improved */
    double viscosity;    /* N s/m */
    double swift;        /* N/m, within one step */
} ss_body_touch;

/* Conjugate gradients of the tangent, node arrays. */
typedef struct ss_body_solver {
    ss_real *inverse, *push, *residual, *search, *scaled, *product, *swift;
    double *stiff; /* N/m, the law's diagonal */
    double rate2;  /* 1/s^2, of the inertia in H */
} ss_body_solver;

/* J; what they are: struct ss_body. */
typedef struct ss_body_energy_balance {
    double kinetic, elastic, shadow, work, dissipated;
} ss_body_energy_balance;

struct ss_body {
    ss_arena arena;     /* all arrays below */
    ss_body_plan own;   /* as given; own.plan points to `plan` */
    ss_model_plan plan; /* `param` is NULL */
    ss_body_nodes nodes;
    int32_t mesh_count;
    const ss_mesh *skin; /* what the contact acts on: the mesh, or the model's own surface */
    bool has_skin;       /* the model's own */
    bool is_held;        /* supports, or its own law, stop every rigid motion */
    bool has_gravity;
    bool has_visible_loads; /* load_force is not all 0 */
    bool is_explicit;       /* the integrator is the body's */
    double diagonal;        /* m, of the mesh's box */
    double small_energy;    /* J: a thousandth of the working force over an edge */
    double sigma;           /* kg/m^2 of the contact surface, mean */
    double total_mass;
    uint8_t *axes;      /* of every node: bits of the axes that are fixed or prescribed */
    ss_real *mass;      /* nodes.mass, for the kernels */
    uint8_t *is_idle;   /* by block of nodes: none has a mass */
    uint8_t *is_source; /* nodes that a grasp may take hold of */
    ss_tools tools;
    ss_body_touch felt[SOFTSIM_MAX_PROBES];
    ss_loads loads;
    ss_inverted inverted;
    ss_prescribed_set *prescribed;
    ss_real *load_force, *old_load; /* N; loads and gravity, and those of the step before */
    /* state beside nodes.u and nodes.v */
    int64_t step;
    int64_t fitted_step; /* that the contact surface was last refitted before; -1 never */
    double work, dissipated, load_work;
    bool is_slowed, was_slowed; /* nodes, in the last step and the one before */
    double speed_limit_loss;    /* J, to the limit of speeds in this outer step */
    double pool;                /* J: gains of the last tenth of a second or so, losses taken off */
    double removed;             /* of the energy: what was taken out again in that time */
    double path;                /* 0..1 of the tools' way, where the sub-step began */
    /* derived; valid while is_ready */
    bool is_ready, has_elastic;  /* forces at the present state; the law's among them */
    double kinetic, elastic;     /* J */
    double twice_kinetic;        /* J: sum m |w|^2 of the last set_motion */
    double shadow;               /* J: what the energy balance takes off kinetic, see body_step.c */
    bool elastic_is_upper_bound; /* as ss_body_energy has it */
    double power;                /* W, of viscosity */
    double booked_lag;           /* s of the lag of v whose dissipation is booked already */
    double law_step;             /* s, of the elastic law alone */
    double bound;                /* s, with contact */
    double longest;              /* s: what a sub-step may take */
    double contact_rate2;        /* 1/s^2 */
    /* scratch */
    ss_real *old_u;                    /* at the start of the outer step */
    ss_body_energy_balance step_start; /* energies then */
    ss_real *stage[5];                 /* RK4: u, v and rate of a stage; new u, sum of rates */
    ss_real *skin_u;                   /* the model's own surface; else NULL and nodes.u is meant */
    ss_real *skin_force;               /* of nodes of the contact surface, clear between calls */
    double *skin_stiff;                /* the same */
    uint8_t *is_stiff;                 /* the same: is the node in stiff_node? */
    int32_t *stiff_node;               /* of the contact surface */
    double *contact_stiff;             /* of nodes, clear between calls */
    ss_body_solver solver;
    /* report */
    int32_t substeps, worst_element, active_nodes;
    double travelled; /* share of the tools' way in the last step */
    uint32_t fault_bits;
    softsim_verdict verdict;
    const char *reason;
};

/* Bytes of a node array. */
static inline size_t ss_body_bytes(const ss_body *body)
{
    return (size_t)body->nodes.padded_count * 4 * sizeof(ss_real);
}

/* The contact surface's displacements that belong to `u`. */
static inline const ss_real *ss_body_skin_u(const ss_body *body, const ss_real *u)
{
    return body->has_skin ? body->skin_u : u;
}

/* ---- body_kernels.c: passes over all nodes ---- */

enum { SS_BODY_BLOCK = 64 }; /* nodes that are summed up together */

/* Seconds by which v is behind its place, by which it is to be ahead, and 1/s. */
typedef struct ss_body_kick {
    double lag, ahead, damping;
} ss_body_kick;

/* What a kick left. */
typedef struct ss_body_speed {
    double twice_kinetic; /* sum m |w|^2 over the axes that may move, J */
    double square;        /* sum |v|^2, not finite when a v is not */
    double loss;          /* J, to the limit */
    bool is_slowed;
} ss_body_speed;

/* With w = (v + lag mobility force)/(1 + lag damping): v := (1 - ahead damping) w + ahead mobility
 * force on axes that may move, slowed to `limit` (m/s) where faster; u += h v. Of `nodes`: mass,
 * mobility and force; `mass`: nodes->mass for kernels. */
ss_body_speed ss_body_kick_drift(const ss_body_nodes *nodes, const uint8_t *is_idle,
                                 const ss_body_kick *kick, double h, double limit,
                                 const ss_real *mass, ss_real *v, ss_real *u);
/* out_rate = mobility force - damping v on axes that may move, else 0. */
void ss_body_rates(int32_t count, double damping, const ss_real *mobility, const ss_real *force,
                   const ss_real *v, ss_real *out_rate);
/* y += s x */
void ss_body_axpy(int32_t count, double s, const ss_real *x, ss_real *y);
/* out = x + s y */
void ss_body_blend(int32_t count, const ss_real *x, double s, const ss_real *y, ss_real *out);
double ss_body_dot(int32_t count, const ss_real *x, const ss_real *y);
/* sum |v|^2: not finite when a v is not. */
double ss_body_square(int32_t count, const ss_real *v);
/* What a time step sees of the motion: with w = (v + lag mobility force)/(1 + lag damping) on axes
 * that may move and v elsewhere, and a = mobility force - damping w: sum m |w|^2 and sum m |a|^2
 * over the axes that may move. Of `nodes`: mobility and force; `mass` as above. */
void ss_body_motion(const ss_body_nodes *nodes, const uint8_t *is_idle, double lag, double damping,
                    const ss_real *mass, const ss_real *v, double *out_twice_kinetic,
                    double *out_rate);
/* Largest |u|^2 of a node (NaN-free input). */
double ss_body_largest(int32_t count, const ss_real *u);

/* ---- body_load.c: loads, prescribed sets, supports ---- */

softsim_status ss_body_loads_create(ss_body *body, softsim_error *error);
/* Loads at `time` into load_force (the last ones into old_load); true when they changed. */
bool ss_body_loads_update(ss_body *body, double time);
/* Is the block of that node without mass? */
void ss_body_set_idle(ss_body *body, int32_t node);
/* What the loads did since old_u, J. */
double ss_body_loads_work(const ss_body *body);
/* Velocities change by what a changed load does in the lag of v, see body_step.c, J. */
double ss_body_loads_lag_work(const ss_body *body);
void ss_body_loads_reset(ss_body *body);
/* Half m v^2 of the prescribed axes, J. */
double ss_body_prescribed_kinetic(const ss_body *body);
/* The power of the supports of prescribed axes, W, at the last evaluation. */
double ss_body_prescribed_power(const ss_body *body);

/* ---- body_contact.c: tools ---- */

softsim_status ss_body_tools_create(ss_body *body, softsim_error *error);
/* kc of all tools, for the planned step. Thread: set-up only. */
void ss_body_set_contact_stiffness(ss_body *body);
void ss_body_tools_reset(ss_body *body);
/* Takes over where the tools go: not ready where one came, left or jumped. */
void ss_body_take_tools(ss_body *body, const ss_model_tool tool[SOFTSIM_MAX_PROBES]);
/* Buttons pressed and released, at the start of a step. */
void ss_body_take_grasps(ss_body *body, const ss_model_tool tool[SOFTSIM_MAX_PROBES]);
/* Sub-steps that the tools' motion asks for: R/4 each, where anything is in the way. */
int32_t ss_body_motion_steps(ss_body *body);
/* Adds contact and grasps at displacements `u`, tools at `path`, to `force`. */
void ss_body_add_contact(ss_body *body, const ss_real *u, double path, ss_real *force);
/* An upper bound of omega^2 of the contact alone, 1/s^2, at the last evaluation. */
double ss_body_contact_rate2(ss_body *body);
/* The contact surface at the end of the step, once a step; returns its displacements. */
const ss_real *ss_body_refit(ss_body *body);

/* ---- body_felt.c: how stiff a tool feels it ---- */

/* Fills tool->rest_felt. Thread: set-up only. */
softsim_status ss_body_set_rest_felt(ss_body *body);
