/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the files of the model cnn-energy share: its parameters, its state and its parts. Private
 * to them; everyone else uses the row in the table of models. cnn_energy.c derives the equations.
 *
 * Memory: all of it is allocated while the model is created. Thread: set-up functions as marked,
 * everything else by the simulation thread and RT-safe.
 */
#include <stdbool.h>
#include <stdint.h>

#include "models/cnn/kernels.h"
#include "models/cnn/network.h"
#include "models/cnn/relax.h"
#include "models/common/inverted.h"
#include "models/common/loads.h"
#include "models/common/plan.h"
#include "models/common/tools.h"
#include "models/model.h"

/* Rows of the parameter table, in its order. */
enum {
    SS_CNN_DOMAIN,
    SS_CNN_MODULUS_J,
    SS_CNN_MODULUS_N_PER_M,
    SS_CNN_MODULUS_PA,
    SS_CNN_PRETENSION_J,
    SS_CNN_ENCLOSED_BULK_PA,
    SS_CNN_RHO,
    SS_CNN_RHO_DIRECTION,
    SS_CNN_RHO_ACROSS,
    SS_CNN_MATERIAL_DIRECTION,
    SS_CNN_PER_AREA,
    SS_CNN_AREA_DENSITY,
    SS_CNN_AREA_DAMPING,
    SS_CNN_AREA_REST_STIFFNESS,
    SS_CNN_VOLUME_DENSITY,
    SS_CNN_VOLUME_DAMPING,
    SS_CNN_VOLUME_REST_STIFFNESS,
    SS_CNN_MASS,
    SS_CNN_DAMPING,
    SS_CNN_REST_STIFFNESS,
    SS_CNN_SATURATION,
    SS_CNN_SOURCE,
    SS_CNN_SOLVER,
    SS_CNN_RELAXATION_STEPS,
    SS_CNN_WINDOW_TOLERANCE,
    SS_CNN_ROW_COUNT
};
extern const ss_param_row ss_cnn_rows_table[SS_CNN_ROW_COUNT];
extern const ss_model_hints ss_cnn_hints;         /* hints.c */
extern const ss_model_potential ss_cnn_potential; /* potential.c */

/* What the body is made of, a value per node, SI. */
typedef struct ss_cnn_material {
    ss_cnn_element element;                  /* what carries the cells */
    double *mass, *damping, *rest_stiffness; /* kg, N s/m, N/m; 0 at nodes that are no cells */
    double *rho;                             /* anisotropic: along the material direction */
    double *rho_across;                      /* NULL: isotropic */
    bool is_modulus_energy;                  /* modulus is E^ in J, else E in N/m (volumes: Pa) */
    double modulus, pretension, bulk, saturation; /* saturation INFINITY: none */
    double window_tolerance; /* a share of the largest displacement; 0: no active set */
} ss_cnn_material;

/* The best rho with which a cell conducts. */
static inline double ss_cnn_best_rho(const ss_cnn_material *material, int32_t node)
{
    const double rho = material->rho[node];
    const double across = material->rho_across ? material->rho_across[node] : rho;
    return rho > across ? rho : across;
}

/* A place where energy enters the network: the cells under a tool, a load or a prescribed patch. */
typedef struct ss_cnn_source {
    bool is_on;
    bool is_tool;
    bool is_placed; /* the tool came where it is without a way there, not weighed since */
    double from;    /* s: a load's source is on from here */
    /* of loads and patches: the cells, increasing, and their weights, sum 1 */
    int32_t cell_count;
    int32_t *cell;
    double *cell_weight;
    /* constant during a sub-step */
    ss_real *kap_edge, *kap, *b; /* edges; entries; quads with the row sum in the fourth lane */
    ss_real *b_turned;           /* free bodies: R b */
    double amplitude;            /* a */
    double reference;            /* psi_0, J: what was there before the tool touched; loads: 0 */
    double given;                /* J: what the fall of psi_0 gave and is not settled yet */
    double modulus;              /* E^, J */
    double eps_limit;            /* eps_s; INFINITY without saturation */
    double qhat, qhat_over_own, inverse_own; /* of loads: means by weight */
    /* at the last evaluation */
    ss_real *r;
    double far; /* u.b of the nodes that do not move by themselves */
    double eps, eta;
    double stretch;        /* the part of eps+ that acts: I_eff / E^ */
    double c1, c2;         /* T + a T0, a T0 */
    double strain_modulus; /* a E^ where the strain term acts, else 0 */
} ss_cnn_source;

/* Sources of loads and patches that may saturate together; more are refused. */
enum { SS_CNN_MAX_SATURATED = 16 };
/* Conditions of a complementarity problem: two a source. */
enum { SS_CNN_LCP_MAX = 2 * SS_CNN_MAX_SATURATED };

typedef struct ss_cnn_saturation {
    /* G: mean potential at the cells of one source (row) for another of 1 J (column) */
    double potential[SS_CNN_MAX_SATURATED][SS_CNN_MAX_SATURATED];
} ss_cnn_saturation;

/* The cell that carries the whole source of a tool, and has the tool pressed on it yet? */
typedef struct ss_cnn_contact_cell {
    int32_t node; /* -1: none, nothing is touched */
    bool has_pressed;
} ss_cnn_contact_cell;

/* What a tool is to the network, beside what every tool is. */
typedef struct ss_cnn_tool {
    ss_tool *base;
    double full_weight; /* W1 */
    ss_cnn_source source;
    /* weights at the last preparation */
    int32_t count;
    const int32_t *node;
    const double *weight;
    int32_t *own_node; /* those two, while there is a grasp */
    double *own_weight;
    double *mu, *eps, *eta, *share;
    ss_cnn_contact_cell cell, cell_before;   /* one-cell sources; before: at the sub-step's start */
    double reference_before, penalty_before; /* at the sub-step's start */
    double given_before;                     /* J, at the sub-step's start */
    double weight_sum, amplitude_slope;
    bool is_fading;        /* 0 < a < 1: W, a and da/dW psi are taken at every stage */
    double *fading_mu;     /* da/dW psi of every touched cell */
    ss_real *weight_slope; /* -dW/dP, quads */
    double mu_largest;     /* of the frozen mu, J/m^2 */
    double frozen_force[3], frozen_torque[3]; /* on the tool, through the weights */
    ss_real *shape_y;                         /* motion of the nodes per unit motion of the tool */
} ss_cnn_tool;

typedef struct ss_cnn_prescribed {
    ss_prescribed_set set;
    int32_t source; /* -1: none of its nodes can carry one */
} ss_cnn_prescribed;

/* What one body of the mesh encloses; see enclosed.c. */
typedef struct ss_cnn_enclosed {
    double volume;   /* V0, m^3 */
    double change;   /* sum N.u at the last evaluation, m^3 */
    double pressure; /* Pa */
    double along;    /* m^3: N.x of the tangent, scratch */
} ss_cnn_enclosed;

/* Sources, and the enclosed volume, whose forces lead the far nodes; see active_set.c. */
enum { SS_CNN_MAX_MODES = 8 };

/* Of a block: the largest |L_k u| / ks and |L_k u| / D_k, and their mean over its nodes, for the u
 * of a mode of unit size. */
typedef struct ss_cnn_mode_error {
    double alone, shared, mean;
} ss_cnn_mode_error;

typedef struct ss_cnn_active_set {
    int32_t block_count, block_size;
    double tolerance;           /* a share of the largest displacement */
    double floor;               /* m: a largest displacement below counts as this */
    double damping_rate, rate2; /* gamma/m and ks/m of every node, 1/s and 1/s^2 */
    int32_t *near_first, *near; /* blocks that share an edge with a block; block_count + 1 */
    uint8_t *is_pinned;         /* blocks with loaded or prescribed nodes */
    uint8_t *distance;          /* 0 a block that moves by itself, 1 and 2 beside such, else 3 */
    ss_cnn_unrest *unrest;      /* of blocks of distance 0 and 1, when looked at */
    ss_cnn_part active, beside, rim, still; /* distance 0; 1; 1 and 2; 1 to 3 */
    int32_t seam_count, *seam;              /* still nodes beside an active one, number x 4 */
    uint8_t *is_seam;                       /* by node */
    int32_t active_nodes;
    int32_t age;    /* sub-steps since the blocks were looked at */
    double tension; /* of all sources then, N */
    bool is_filled; /* u and v of still nodes are as they should be */
    /* modes: sources in their order, then the enclosed volume */
    int32_t mode_count;
    const ss_real *f[SS_CNN_MAX_MODES]; /* force for a unit tension or pressure, quads */
    double y[SS_CNN_MAX_MODES], w[SS_CNN_MAX_MODES]; /* N s^2 or Pa s^2, and its rate */
    double old_y[SS_CNN_MAX_MODES], old_w[SS_CNN_MAX_MODES];
    double now_y[SS_CNN_MAX_MODES], now_w[SS_CNN_MAX_MODES]; /* at the evaluation under way */
    double sum_y[SS_CNN_MAX_MODES], sum_w[SS_CNN_MAX_MODES]; /* of the stages */
    double *gram;                  /* sum f_m.f_l / m of a block, mode_count^2 of each */
    ss_cnn_mode_error *mode_error; /* source_count x mode_count of each block */
    double shared[SS_CNN_MAX_MODES][SS_CNN_MAX_MODES]; /* the same of all still blocks */
} ss_cnn_active_set;

struct ss_model {
    ss_arena arena;
    ss_model_plan plan;
    int32_t node_count;
    const ss_cnn_kernels *kernels;
    ss_cnn_material material;
    ss_cnn_network *network;
    bool is_held; /* supports stop every rigid motion: P* = P0 */
    bool has_gravity;
    bool is_one_cell;      /* a source is the contact cell alone, equation (10) */
    bool is_relaxed;       /* the network in its own time, equation (2) */
    ss_cnn_relax *relax;   /* NULL at equilibrium */
    double diagonal;       /* m */
    double small_energy;   /* J: what no hand feels; without tools, rounding */
    double smallest_sigma; /* kg/m^2 of the surface */
    double damping_rate_min, damping_rate_max; /* gamma/m, 1/s */
    double bulk_rate;                          /* largest (B/V0) sum |N|^2/m, 1/s^2 */
    int32_t enclosed_count;                    /* bodies with B; 0 without */
    ss_cnn_enclosed *enclosed;                 /* by body */
    int32_t *body;                             /* of each node; NULL where there is one */
    uint8_t *held;                             /* cells held at zero: fixed on all axes */
    ss_cnn_span whole_span;
    ss_cnn_part whole;         /* all nodes and rows that may move */
    const ss_cnn_part *part;   /* those that a step works on: all, or the active set's */
    ss_cnn_active_set *set;    /* NULL: none */
    const char *no_set_reason; /* why there is no active set */
    /* per node, for the kernels */
    ss_real *mass, *damping, *rest_stiffness;
    ss_real *mobility, *normal; /* quads; normal NULL without B */
    double *mobility_max;       /* 1/m, 0 where no axis is free */
    /* tools, loads, prescribed nodes */
    ss_tools tools;
    ss_cnn_tool tool[SOFTSIM_MAX_PROBES];
    ss_loads loads;
    ss_cnn_prescribed *prescribed;
    ss_cnn_source *source; /* of loads and prescribed patches */
    int32_t source_count;
    ss_cnn_saturation *saturation; /* NULL: none, or too few sources to share cells */
    /* state */
    ss_real *u, *v, *u_low;
    int64_t step;
    double work, dissipated, load_work;
    /* derived from the state; valid while is_ready */
    bool is_ready, has_strain, has_totals;
    bool has_loads_only;            /* base and force are load_force: no tool, no second source */
    ss_cnn_totals totals;           /* of u and v, where has_totals */
    double kinetic, elastic, bound; /* J, J, s */
    const ss_real *d;               /* P - P* at the last evaluation: u, or fitted */
    const ss_cnn_source *first;     /* the source that `force` does not hold yet; NULL: none on */
    double rotation[3][3], centroid_rest[3], fit_weight; /* of a free body; fit_weight = sum ks */
    /* scratch */
    ss_real *old_u, *old_v, *old_low; /* at the start of the sub-step; swapped with u, v */
    ss_real *us, *vs[3];
    ss_real *load_force, *base, *force; /* loads; and f_s; and contact */
    ss_real *fitted;                    /* P - P* of a free body */
    ss_real *strain, *stretch;          /* edges */
    ss_real *held_kap, *held_b;         /* reactions */
    ss_real *inverse, *push, *residual, *search, *scaled, *product; /* the tangent's solve */
    double *stiff;                                                  /* rows of the step bound */
    const ss_real **column;
    /* report */
    ss_inverted inverted;
    int32_t worst; /* a corner of a tetrahedron inside out, -1 none */
    int32_t substeps;
    double pool;      /* J: gains of the last tenth of a second or so, losses taken off */
    double owed;      /* J: what falls of psi_0 gave and is not yet out of the motion */
    double damped;    /* J: what was taken out for them in the last step */
    double travelled; /* share of the tools' way in the last step */
    uint32_t fault_bits;
    softsim_verdict verdict;
    const char *reason;
};

/* ---- material.c: parameters to values a node, and everything refused about them ---- */

/* Thread: set-up only. */
softsim_status ss_cnn_material_create(const ss_model_plan *plan, ss_arena *arena,
                                      ss_cnn_material *out_material, softsim_error *error);
/* What the network is made of; points into plan and material. Thread: set-up only. */
ss_cnn_fabric ss_cnn_material_fabric(const ss_model_plan *plan, const ss_cnn_material *material);
/* Faults of fixed nodes, loads, prescribed sets and tools against the mesh; out_is_held: do the
 * fixed and prescribed axes stop every rigid motion of the body? Thread: set-up only. */
softsim_status ss_cnn_plan_check(const ss_model_plan *plan, const ss_cnn_material *material,
                                 bool *out_is_held, softsim_error *error);

/* ---- enclosed.c: what the bodies enclose ---- */

/* Finds the bodies, their volumes and the pressure's share of the step bound; nothing without B.
 * Thread: set-up only. */
softsim_status ss_cnn_enclosed_create(ss_model *model, softsim_error *error);
/* N for the stage, which takes the pressure of one body along; NULL: none, or several, whose
 * pressures ss_cnn_enclosed_evaluate puts into model->force. */
const ss_real *ss_cnn_enclosed_normal(const ss_model *model);
/* Pressures at displacements `u`. One body: `change` belongs to u but for `far_change` of the
 * active set; several: model->force must hold no pressure yet. */
void ss_cnn_enclosed_evaluate(ss_model *model, const ss_real *u, double far_change);
/* out += (B/V0) N (N.x) for every body; returns x.out. */
double ss_cnn_enclosed_tangent(const ss_model *model, const ss_real *x, ss_real *out);
double ss_cnn_enclosed_energy(const ss_model *model);

/* ---- source.c: where energy enters the network ---- */

/* Allocates one source; free bodies need b_turned. Thread: set-up only. */
softsim_status ss_cnn_source_init(ss_model *model, ss_cnn_source *source);
/* A source of fixed weights (they sum to 1) over `node`. Thread: set-up only. */
softsim_status ss_cnn_source_fix(ss_model *model, int32_t count, const int32_t *node,
                                 const double *weight, ss_cnn_source *source);
/* With the network in its own time: kap of the loads' sources from what their cells have spread;
 * begins a new look at the cells in use. Before the tools are weighed. */
void ss_cnn_source_relax(ss_model *model);
/* Moduli and saturation of all sources from the material's present values. */
void ss_cnn_source_moduli(ss_model *model);
/* Weighs the tissue under a tool at `pose`: kap, eps_i, a, and the forces f_s through the
 * weights, which are added to model->base. */
void ss_cnn_source_weigh(ss_model *model, ss_cnn_tool *tool, const ss_tool_pose *pose);
/* The forces on the nodes through the weights at the last preparation, quads (scratch): what a
 * grasp takes over. */
const ss_real *ss_cnn_source_weight_forces(ss_model *model, ss_cnn_tool *tool);
/* What the source's energy lost as psi_0 or held weights changed; what it gained is booked as work
 * and goes out of the motion again (spring.c). */
void ss_cnn_source_book(ss_model *model, ss_cnn_source *source, double lost);
/* The tool has left, or jumped: its next touch begins again. */
void ss_cnn_source_end_contact(ss_cnn_tool *tool);
/* What the tools' sources remember of their touch, put aside and put back around a sub-step. */
void ss_cnn_source_keep(ss_model *model);
void ss_cnn_source_restore(ss_model *model);
/* While a tool is_fading: W and a at a stage, before its source is evaluated; the force through W
 * after it, added to model->force and the tool's; and its stiffness: rows added to model->stiff,
 * and the square of a rate (1/s^2) returned. */
void ss_cnn_source_fade(ss_model *model, ss_cnn_tool *tool, const ss_real *u,
                        const ss_tool_pose *pose);
void ss_cnn_source_add_fading(ss_model *model, ss_cnn_tool *tool);
double ss_cnn_source_fading_stiffness(ss_model *model, ss_cnn_tool *tool);
/* r = b + L d, then eps, eta and the tensions c1, c2, saturated as if it were alone. */
void ss_cnn_source_evaluate(const ss_model *model, ss_cnn_source *source, const ss_real *d);
/* Tensions for a stretch that acts; `is_free`: it still grows with eps. */
void ss_cnn_source_set_stretch(const ss_model *model, ss_cnn_source *source, double stretch,
                               bool is_free);
/* Energy of the source at its last evaluation: a (psi - psi_0), J. */
double ss_cnn_source_energy(const ss_model *model, const ss_cnn_source *source);
/* Source `index` of source_count + SOFTSIM_MAX_PROBES (loads and patches first, then tools), or
 * NULL where it is not on. */
ss_cnn_source *ss_cnn_source_on(ss_model *model, int32_t index);

/* ---- spring.c: strained tissue that springs back under a tool ---- */

/* After a sub-step of `h` s: what falls of psi_0 gave, booked as work, goes out of the motion. */
void ss_cnn_spring_settle(ss_model *model, double h);

/* ---- saturate.c: several sources at the output K ---- */

/* Solves z >= 0, w = q + M z >= 0, z.w = 0 for a symmetric positive semidefinite M of n x n (at
 * most SS_CNN_LCP_MAX) whose entries are of order 1. Exact to rounding; false where there is no
 * solution. Thread: any, RT-safe. */
bool ss_cnn_lcp(int32_t n, const double *matrix, const double *q, double *out_z);
/* X = argmin sum (X_k - wish_k)^2 / metric_k with X >= 0 and G X <= limit, for count at most
 * SS_CNN_MAX_SATURATED, not all wishes 0; G (potential) is count x count, >= 0. out_bound: how
 * many conditions hold X where it is. False: not solved to rounding. Thread: any, RT-safe. */
bool ss_cnn_project(int32_t count, const double *metric, const double *potential, double limit,
                    const double *wish, double *out_strength, int32_t *out_bound);
/* G of the model's sources, where K is finite and there are several. Thread: set-up only. */
softsim_status ss_cnn_saturation_create(ss_model *model, softsim_error *error);
/* After all sources are evaluated: those of loads and patches share what K leaves them. */
void ss_cnn_saturate(ss_model *model);
/* The literal |y| <= K for given currents >= 0 on `count` (at most SS_CNN_LCP_MAX) cells of parts
 * that have a cell held at zero: the network's settled outputs, a value a node. For comparison
 * with the network in its own time. Thread: set-up only. */
softsim_status ss_cnn_obstacle(ss_cnn_network *network, int32_t count, const int32_t *node,
                               const double *current, double saturation, double *out_potential);

/* ---- step.c: time ---- */

void ss_cnn_step(ss_model *model, double time, double dt,
                 const ss_model_tool tool[SOFTSIM_MAX_PROBES]);
/* model->stiff and model->bound from the last evaluation. */
void ss_cnn_set_bound(ss_model *model);

/* ---- rk4.c ---- */

/* The largest stable RK4 step for modes with damping rates d_min..d_max and frequencies up to
 * sqrt(omega2). Thread: any. */
double ss_cnn_rk4_limit(double d_min, double d_max, double omega2);

/* ---- active_set.c: parts of a large body that need no step of their own ---- */

/* Fills model->whole and, where the plan allows it, model->active set; model->part is either of
 * them afterwards. Thread: set-up only. */
softsim_status ss_cnn_active_set_create(ss_model *model);
/* Only the pinned blocks are active, and the modes at rest. */
void ss_cnn_active_set_reset(ss_model *model);
/* Everything below does nothing in a model without an active set.
 * The far field into `u` beside the active blocks, and into the sources, at the evaluation under
 * way; returns its share of sum N.u. */
double ss_cnn_active_set_evaluate(ss_model *model, ss_real *u);
/* The modes' part of Runge-Kutta stage `index` of `h` seconds; returns the damping's power. */
double ss_cnn_active_set_stage(ss_model *model, int index, double h);
void ss_cnn_active_set_swap(ss_model *model);
/* The far field's velocities times `factor`. */
void ss_cnn_active_set_damp(ss_model *model, double factor);
/* Adds what the still nodes have of kinetic and rest energy. */
void ss_cnn_active_set_add_totals(const ss_model *model, ss_cnn_totals *totals);
/* sum |f|^2/m of mode `index` over the still nodes. */
double ss_cnn_active_set_stiffness(const ss_model *model, int32_t index);
/* After a sub-step: true when other blocks are active than before. */
bool ss_cnn_active_set_look(ss_model *model);
/* u and v of every node. */
void ss_cnn_active_set_fill(const ss_model *model);

/* ---- fit.c: free bodies ---- */

/* P - P* of the displacements `u`: themselves in a held body, else the best rigid fit is taken
 * out (rotation and centroid are kept in the model). */
const ss_real *ss_cnn_fit(ss_model *model, const ss_real *u);

/* ---- load.c: what acts without a tool ---- */

/* Sources and lists of loads and prescribed sets. Thread: set-up only. */
softsim_status ss_cnn_loads_create(ss_model *model, softsim_error *error);
/* How much of each load acts at `time`, and sources switched on; true when forces must be built. */
bool ss_cnn_loads_update(ss_model *model, double time);
/* Forces of loads and gravity into model->load_force. */
void ss_cnn_loads_build(ss_model *model);
/* The work of loads and gravity since old_u, J. */
double ss_cnn_loads_work(const ss_model *model);
/* Prescribed axes go from where they are to where they belong at `time`. */
void ss_cnn_prescribed_update(ss_model *model, double time);
/* Puts prescribed nodes at `path` of the outer step, moving so that they cover `fraction` in `h`.
 */
void ss_cnn_prescribed_place(ss_model *model, double path, double fraction, double h);
/* The work of prescribed nodes during a stage of weight `share` of a sub-step of `h`, J. */
double ss_cnn_prescribed_work(const ss_model *model, const ss_real *d, const ss_real *v, double h,
                              double share);
/* Force of the support on the body, see model.h. */
void ss_cnn_reaction(const ss_model *model, int32_t set, double out_force[3]);

/* ---- contact.c: what the hand is told ---- */

/* Fills tool->rest_felt: what a node of usual spread shows at rest. Thread: set-up only. */
softsim_status ss_cnn_set_rest_felt(ss_model *model);
void ss_cnn_contacts(ss_model *model, int32_t probe, double near, ss_contact_set *out);

/* ---- world/explain.c ---- */

double ss_cnn_step_cost_us(const ss_model_plan *plan);
void ss_cnn_explain(const ss_model *model, const ss_notes *out);
/* Contact stiffness for a tool of radius R (m): stability and penetration at the working force. */
double ss_cnn_contact_stiffness(const ss_model_plan *plan, double sigma, double radius);
