/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Private to cnn-chainmail: its parameters, its state, and what its files call of one another.
 * cnn_chainmail.c has the equations and the class; material.c reads the parameters;
 * step.c steps; contact.c is where tools touch, felt.c how stiff that feels; load.c everything that
 * acts without a tool; coarse.c the coarse level and aggregated cells; guard.c keeps tetrahedra
 * from turning inside out; net.c and kernels.c the links; cost.c counts what a step costs; state.c
 * is what all of them do to the state.
 *
 * Displacements and pulls dP are in metres, energies of the network W in square metres; a link's
 * tension is k w ex, so energy is 2 k W and a force f is a current f/(2 k).
 */
#include "models/chain/kernels.h"
#include "models/common/inverted.h"
#include "models/common/loads.h"
#include "models/common/plan.h"
#include "models/common/tools.h"
#include "models/model.h"

/* Rows of the model's table. */
enum {
    SS_CHAIN_ALPHA,
    SS_CHAIN_TOE_FORCE_N,
    SS_CHAIN_STIFFNESS_N_PER_M,
    SS_CHAIN_CAPACITANCE_S,
    SS_CHAIN_SATURATION_SIZES,
    SS_CHAIN_SOURCE,
    SS_CHAIN_UNLOADING,
    SS_CHAIN_LEAK,
    SS_CHAIN_TET_GUARD,
    SS_CHAIN_CELLS,
    SS_CHAIN_COARSE_CELLS,
    SS_CHAIN_ROW_COUNT
};
extern const ss_param_row ss_chain_rows[SS_CHAIN_ROW_COUNT];

typedef enum ss_chain_unloading {
    SS_CHAIN_RAMP,
    SS_CHAIN_LITERAL,
    SS_CHAIN_KEEP
} ss_chain_unloading;

/* How far something has pushed in, for the unloading rules. */
typedef struct ss_chain_drive {
    double depth, most; /* m, now and since it began; both 0 where nothing is prescribed */
    bool is_falling;
} ss_chain_drive;

/* What a tool is to the chain, beside what every tool is. */
typedef struct ss_chain_tool {
    ss_tool *base;
    bool is_touching; /* at the last sub-step */
    bool grasp_wish;  /* the button is down, and it is not torn */
    double viscosity; /* N s/m, last told */
    ss_chain_drive drive;
} ss_chain_tool;

typedef struct ss_chain_prescribed {
    ss_prescribed_set set;
    bool is_moving;
    double reaction[3]; /* N, of the support on the body */
    ss_chain_drive drive;
} ss_chain_prescribed;

typedef struct ss_chain_coarse ss_chain_coarse; /* coarse.c */
typedef struct ss_chain_guard ss_chain_guard;   /* guard.c */
typedef struct ss_chain_felt ss_chain_felt;     /* felt.c */

struct ss_model {
    ss_arena arena;
    ss_model_plan plan;
    int32_t node_count;
    int32_t padded; /* nodes of arrays: one more, and an even number */
    const ss_chain_kernels *kernels;
    ss_chain_net *net;
    /* material */
    double k;            /* N/m: what weights refer to */
    double capacitance;  /* s, the mean */
    double *conductance; /* 1/C of every node, 1/s */
    double *valence;     /* s_i: sum of weights */
    double leak;         /* 1/R_rest, 0 none */
    double saturation;   /* m, radius of the output; INFINITY none */
    ss_chain_unloading unloading;
    bool is_current; /* contact is a current source, else cells are held */
    bool has_alpha;  /* a link has slack */
    bool is_capacitance_given;
    double fine_rate;   /* 1/s: 2/rate is the largest stable step without the coarse level */
    double rate;        /* with it */
    double diagonal;    /* m */
    double small;       /* J: what is not judged */
    bool is_held;       /* supports stop every rigid motion */
    uint8_t *is_bound;  /* nodes with a fixed or prescribed axis */
    uint8_t *is_placed; /* scratch: nodes of the set that is moved */
    int32_t *fixed;     /* nodes with a fixed axis */
    int32_t fixed_count;
    ss_chain_coarse *coarse; /* NULL: none */
    ss_chain_guard *guard;   /* NULL: none */
    ss_chain_felt *felt;     /* NULL: no tool */
    /* what acts */
    ss_tools tools;
    ss_chain_tool tool[SOFTSIM_MAX_PROBES];
    ss_loads loads;
    ss_chain_prescribed *prescribed;
    ss_real *current; /* of loads, m, quads */
    bool has_current;
    /* state */
    ss_real *u, *v;
    double ratio;     /* of alpha: 1, less while unloading */
    bool has_touched; /* something has moved it since rest */
    int64_t step;
    int64_t fitted_step;    /* that the contact surface was last refitted before; -1 never */
    double work, load_work; /* J; of it by loads and supports */
    ss_chain_front front;
    bool is_all_awake; /* the front is not known: everything is looked at */
    bool is_crowded;   /* the front is most of the body */
    int32_t age;       /* sub-steps since the front was */
    int32_t stride;    /* sub-steps from one of the aggregated cells to the next */
    /* scratch */
    ss_real *mobility, *free; /* 1/C (1/s), and 1, of every axis that may move, else 0 */
    ss_real *pull;
    ss_real *output;   /* Q = sat(u); u itself without saturation */
    bool is_saturated; /* Q is not u */
    ss_real *contact;
    double *diagonal_of; /* N/m, of contact */
    double *firmness;    /* the same of one tool */
    int32_t *touched;    /* nodes under tools at the last sub-step, increasing within a tool */
    int32_t touched_count;
    uint8_t *is_touched;
    int32_t *hold; /* cells and weights (m^2) that a grasp takes */
    double *hold_weight;
    ss_real *push; /* of the stiffness estimate */
    /* report */
    double network;  /* W of the last sub-step, m^2 */
    int32_t guarded; /* tetrahedra that the guard put back in the last step */
    ss_inverted inverted;
    double first_network;               /* W of the outer step's first, cells moved */
    double elastic, dissipated, booked; /* J, at one moment: booked is the work until then */
    double gained;                      /* J, from nowhere, until then */
    double fixed_reaction[3];
    int32_t substeps, active_nodes, worst_element;
    double travelled; /* share of the tools' way in the last step */
    uint32_t fault_bits;
    softsim_verdict verdict;
    const char *reason;
};

/* ---- state.c ---- */
/* A verdict that is worse than what was said so far in this step. */
void ss_chain_tell(ss_model *model, softsim_verdict verdict, const char *reason);
/* All groups of a node are looked at in the next sub-step. */
void ss_chain_wake(ss_model *model, int32_t node);

/* ---- cost.c ---- */
/* s: the sub-step that C is chosen for where none is given: the shortest, but no less than 1/8 ms,
 * whose counted work is a quarter of the time that it simulates. The shorter, the smaller C, and
 * with it the drag that a tool feels. It follows the mesh, not the step: a tissue is no other at 60
 * Hz than at 1000. A step takes as many as it needs; where it may not, C is larger. */
double ss_chain_planned_substep(const ss_model_plan *plan);
double ss_chain_step_cost_us(const ss_model_plan *plan);

/* ---- material.c ---- */
/* Parameters into links and nodes; everything refused about them. Thread: set-up only. */
softsim_status ss_chain_material_create(ss_model *model, softsim_error *error);
/* Sets capacitance where none was given, and the rates. After the coarse level. Out of memory at
 * worst. Thread: set-up only. */
softsim_status ss_chain_material_time(ss_model *model);
/* The largest stable step, s. */
double ss_chain_stable_step(const ss_model *model);

/* ---- load.c ---- */
softsim_status ss_chain_loads_create(ss_model *model, softsim_error *error);
/* Currents of the loads at `time`, which is the middle of the step. */
void ss_chain_loads_update(ss_model *model, double time);
/* Where prescribed nodes go in the outer step that ends at `time`. */
void ss_chain_prescribed_update(ss_model *model, double time);
/* Puts them at `path` (0..1) of it and books the work. */
void ss_chain_prescribed_place(ss_model *model, double path);
/* What the links of some nodes store, J. */
double ss_chain_energy_around(ss_model *model, int32_t count, const int32_t *node);
/* Adds currents to pull. */
void ss_chain_loads_apply(ss_model *model);
/* What supports answer to pull; not `is_full`: of the front's nodes. */
void ss_chain_sample_reactions(ss_model *model, bool is_full);
/* `sign` times 2 k sum I.u, J: before and after a sub-step, the difference is the loads' work. */
double ss_chain_loads_work(const ss_model *model, double sign);

/* ---- contact.c ---- */
softsim_status ss_chain_tools_create(ss_model *model, softsim_error *error);
void ss_chain_tools_reset(ss_model *model);
void ss_chain_tools_take(ss_model *model, const ss_model_tool tool[SOFTSIM_MAX_PROBES]);
/* Sub-steps that the tools' motion asks for. */
int32_t ss_chain_tools_substeps(ss_model *model);
/* Moves the tools on to `path` of the step: contact forces, firmness and work. */
void ss_chain_tools_touch(ss_model *model, bool is_first, double path);
/* Contact into pull: cells under tools are held as firmly as contact is stiff. */
void ss_chain_tools_apply(ss_model *model, double h);
/* What the tools feel at the end of the step. */
void ss_chain_tools_sample(ss_model *model);
void ss_chain_contacts(ss_model *model, int32_t probe, double near, ss_contact_set *out);

/* ---- felt.c ---- */
softsim_status ss_chain_felt_create(ss_model *model);
void ss_chain_felt_reset(ss_model *model);
/* Sets the stiffness that tool `probe`, which touches, is told along unit `normal` (tool->felt);
 * returns the viscosity, N s/m. */
double ss_chain_feel(ss_model *model, int probe, const double normal[3]);
/* As of ss_model_class. */
void ss_chain_slept(ss_model *model, int64_t steps);

/* ---- coarse.c ---- */
softsim_status ss_chain_coarse_create(ss_model *model, int32_t cells, bool is_aggregated);
void ss_chain_coarse_reset(ss_model *model);
/* Makes D, and the largest rate of both levels together (of aggregated cells alone), 1/s, with the
 * leak; 0 where nothing may move, negative without memory. Thread: set-up only. */
double ss_chain_coarse_rate(ss_model *model);
int32_t ss_chain_coarse_cells(const ss_chain_coarse *coarse);
const ss_chain_hats *ss_chain_coarse_hats(const ss_chain_coarse *coarse);
int64_t ss_chain_coarse_bytes(const ss_chain_coarse *coarse);
/* Moves all nodes by the coarse level's share of pull; is_first: of an outer step. */
void ss_chain_coarse_move(ss_model *model, double h, bool is_first);

/* Are the elements aggregated into cells? Those below are for then. */
bool ss_chain_is_aggregated(const ss_model *model);
/* Their rate by `factor` less, as the capacitance is more. */
void ss_chain_aggregated_slow(ss_model *model, double factor);
/* The largest stable step of the cells, s. */
double ss_chain_aggregated_step(const ss_model *model);
/* Once an outer step: elements near what pushes become cells of their own. */
void ss_chain_refine(ss_model *model);
/* The groups of those elements, and no others, are awake. */
void ss_chain_wake_own(ss_model *model);

/* ---- guard.c ---- */
softsim_status ss_chain_guard_create(ss_model *model);
/* One projection of every tetrahedron below a fifth of its volume. */
void ss_chain_guard_step(ss_model *model);
/* Notes where the outer step begins; takes `share` of the way since then back. */
void ss_chain_guard_begin(ss_model *model);
void ss_chain_guard_withdraw(ss_model *model, double share);

/* ---- step.c ---- */
void ss_chain_step(ss_model *model, double time, double dt,
                   const ss_model_tool tool[SOFTSIM_MAX_PROBES]);

/* ---- explain.c ---- */
void ss_chain_explain(const ss_model *model, const ss_notes *out);
