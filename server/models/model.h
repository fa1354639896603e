/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How tissue deforms: one interface, one folder per model, one row in the table of models.
 *
 * In: a plan (mesh, fixed nodes, parameters, tools, loads) and, each step, where the tools go.
 * Out: node displacements, a contact set per tool with its stiffness, energies, verdict.
 * All memory is allocated by the class's `create`; stepping is RT-safe and deterministic: equal
 * input gives equal bits, whatever the number of threads.
 */
#include <stdbool.h>
#include <stdint.h>

#include "contact/contact.h"
#include "mesh/mesh.h"
#include "models/hints.h"
#include "rt/note.h"
#include "rt/param.h"
#include "rt/real.h"
#include "softsim/types.h"

/* A prescribed displacement from rest; reactions are reported per set. */
typedef struct ss_prescribed {
    int32_t *node;
    int32_t node_count;
    double (*displacement)[3]; /* m, per node of the set */
    bool axis[3];
    double from, ramp; /* s */
} ss_prescribed;

typedef struct ss_tool_plan {
    bool is_used;
    ss_shape shape; /* borrowed: outlives the model */
} ss_tool_plan;

/* Everything it points to is borrowed and outlives the model, but `param`. */
typedef struct ss_model_plan {
    const ss_mesh *mesh;
    const ss_mesh *surface;      /* a finer one of the same body, for curved edges; NULL: none */
    const uint8_t *fixed;        /* node_count: bit 0 x, 1 y, 2 z */
    const ss_param_value *param; /* in the order of the model's table */
    const ss_load *load;
    int32_t load_count;
    const ss_prescribed *prescribed;
    int32_t prescribed_count;
    ss_tool_plan tool[SOFTSIM_MAX_PROBES];
    double gravity[3];              /* m/s^2 */
    double working_force;           /* N; the contact stiffness is chosen from it */
    double contact_stiffness;       /* N/m^3; 0: chosen */
    double contact_reach;           /* m, of the source weights; 0: max(mean edge, R/2) */
    double friction;                /* mu of contact.friction; 0: none */
    const double *friction_by_node; /* in its place; NULL: the same everywhere */
    double grasp_max_force;         /* N, a grasp is torn above; 0 or NaN: none is */
    int32_t contact_parts;          /* as ss_surface_create takes it; 0: chosen */
    double max_force;               /* N, the haptic limit: for the penetration warning */
    double step;                    /* s, the outer step the world intends */
    double yardstick;               /* a step takes that much of its counted cost; 0: as counted */
    int32_t max_substeps;           /* that a step may take */
    int32_t substep_budget; /* simulation.max_substeps, whether a step is held to it or not: what
                               is planned is the same in real time and without a clock; 0: as
                               max_substeps */
    int32_t threads;        /* for set-up work; results do not depend on it */
} ss_model_plan;

/* The value of parameter row `row` in tetrahedron `e`: its own, or the mean of its corners. Thread:
 * any. */
double ss_plan_element_value(const ss_model_plan *plan, int row, int32_t e);

typedef struct ss_model ss_model;

/* Where one tool goes during a step. */
typedef struct ss_model_tool {
    bool is_present;
    bool is_grasping;
    ss_tool_pose from, to;
} ss_model_tool;

/* Bits of ss_model_info.fault_bits; they stay set until reset. */
enum {
    SS_MODEL_FAULT_NOT_FINITE = 1, /* the last good state was restored; no step until reset */
    SS_MODEL_FAULT_BUDGET = 2,     /* more sub-steps were needed than allowed: slower than time */
    SS_MODEL_FAULT_CLAMPED = 4,    /* a displacement beyond any meaning was cut off */
    SS_MODEL_FAULT_ENERGY = 8      /* spurious energy, or more than any work explains */
};

typedef struct ss_model_info {
    int64_t step;
    int32_t substeps; /* of the last step */
    int32_t active_nodes;
    int32_t worst_element; /* a tetrahedron where needs_volume, else a node; -1 none */
    uint32_t fault_bits;
    softsim_verdict verdict;
    const char *reason; /* static text; "" when good */
    double stable_step; /* s, computed for the present state */
    double travelled;   /* share of the way of tools and prescribed nodes in the last step: 1, and
                           less in a step that was slower than time */
    double kinetic, elastic, dissipated, work; /* J; work: done by tools and loads since start */
    double load_work; /* J: the part of it that loads, gravity and supports did */
} ss_model_info;

struct ss_layer;

/* What a model that has a layer of particles (layer.h) tells of it. */
typedef struct ss_model_layer {
    /* Share of layer.max_active that may wake; the rest is for those that fall asleep. */
    double full;
    const struct ss_layer *(*at_rest)(const ss_model *model);
    bool (*is_awake)(const ss_model *model, int32_t particle);
    /* How much of the way of skin node `skin` is that of particles: 0 tied to the core, 1 all. */
    double (*share)(const ss_model *model, int32_t skin);
} ss_model_layer;

/* The body as a model has it: the nodes of its plan's mesh come first, with `middle` each face of
 * the surface is four triangles (mesh.h). Belongs to the model. */
typedef struct ss_model_shape {
    const ss_mesh *mesh;
    const uint8_t *fixed; /* of each node, as in the plan */
} ss_model_shape;

/* A potential of the model's own, in joules, for who wants to see it. A step only says what acts;
 * what that spreads is found elsewhere. */
typedef struct ss_model_potential {
    /* What acts, a value a node. RT-safe. */
    void (*tell)(const ss_model *model, float *out_source);
    /* The potential of every node for it. Reads nothing that a step changes. False: out of memory.
     * Thread: one that may allocate. */
    bool (*find)(const ss_model *model, const float *source, float *out_potential);
} ss_model_potential;

typedef struct ss_model_class {
    const char *name;
    const char *help;
    const ss_model_hints *hints; /* NULL: a solid, and the reports leave it out */
    const ss_param_row *row;
    int32_t row_count;
    bool needs_volume;
    bool takes_friction;       /* its contacts hold the tool along the surface, too */
    bool grasps_without_force; /* what it holds goes along, and pulls at no tool: nothing tears */
    bool takes_second_order;   /* meshes with mid-edge nodes; others are refused */
    bool has_no_energy;        /* a rule for shapes: the energies that info tells are 0 */
    /* Estimated cost of one step in microseconds on the reference core, from counts alone; with a
     * plan->step of 0, which is not chosen yet, of a short one. */
    double (*step_cost_us)(const ss_model_plan *plan);
    size_t size; /* bytes of the struct ss_model */
    /* Fills a zeroed model from `plan`; neither `plan` nor `error` is NULL. What it leaves behind
     * when it fails is for `destroy`. Thread: set-up only. */
    softsim_status (*build)(ss_model *model, const ss_model_plan *plan, softsim_error *error);
    void (*destroy)(ss_model *model); /* not NULL; frees it, too */
    /* One outer step of `dt` seconds from time `time` (sub-stepped inside). Where the sub-steps
     * that are allowed simulate only a share of dt, tools travel that share of their way and stand
     * there (ss_model_reached): the next step sweeps on from that place. RT-safe. */
    void (*step)(ss_model *model, double time, double dt,
                 const ss_model_tool tool[SOFTSIM_MAX_PROBES]);
    /* The contact set of tool `probe` after the last step, stiffness and viscosity filled; nearest
     * patch within `near` metres when nothing touches. RT-safe. */
    void (*contacts)(ss_model *model, int32_t probe, double near, ss_contact_set *out);
    /* Back to rest, at fault or not. RT-safe. */
    void (*reset)(ss_model *model);
    void (*info)(const ss_model *model, ss_model_info *out);
    /* Displacement and velocity of every node, 4 ss_real a node, valid until the next step. */
    const ss_real *(*displacement)(const ss_model *model);
    const ss_real *(*velocity)(const ss_model *model);
    /* Force of the support on the body for prescribed set k, or for the fixed nodes with -1, N. */
    void (*reaction)(const ss_model *model, int32_t set, double out_force[3]);
    /* FNV-1a 64 of whatever else is state. */
    uint64_t (*hash)(const ss_model *model, uint64_t seed);
    /* What the plan uses, leaves out and doubts, a note each. Thread: set-up only. */
    void (*explain)(const ss_model *model, const ss_notes *out);
    const ss_model_layer *layer;         /* NULL: none */
    const ss_model_potential *potential; /* NULL: none */
    /* Of a model with more nodes than its plan, or others: displacement and velocity then tell of
     * all of them. NULL: the plan's mesh. */
    void (*shape)(const ss_model *model, ss_model_shape *out);
    /* `steps` were left out, in which it was at rest: what is done every few steps keeps its turn.
     * NULL: nothing is. RT-safe. */
    void (*slept)(ss_model *model, int64_t steps);
    /* Sets row `index` while running (rows with is_live); NULL without any. RT-safe. */
    void (*set)(ss_model *model, int32_t index, double value);
} ss_model_class;

/* A class, the object of that name, from its name in a scene, its help and the two below; the other
 * fields, where they are not 0, stand behind. */
#define SS_MODEL_CLASS(object, its_name, its_help, ...)                                            \
    extern const ss_model_class object;                                                            \
    const ss_model_class object = {.name = (its_name), .help = (its_help), __VA_ARGS__}
/* What it is made of, by the names that its functions have. */
#define SS_MODEL_PARTS(type, its_hints, rows, cost, build_it, destroy_it, step_it, explain_it)     \
    .hints = (its_hints), .row = (rows), .row_count = (int32_t)(sizeof(rows) / sizeof *(rows)),    \
    .step_cost_us = (cost), .size = sizeof(type), .build = (build_it), .destroy = (destroy_it),    \
    .step = (step_it), .explain = (explain_it)
/* And what tells its state. */
#define SS_MODEL_STATE(contacts_of, reset_it, info_of, u_of, v_of, reaction_of, hash_of)           \
    .contacts = (contacts_of), .reset = (reset_it), .info = (info_of), .displacement = (u_of),     \
    .velocity = (v_of), .reaction = (reaction_of), .hash = (hash_of)

/* A model of that class in *out_model; NULL after a failure. `error` may be NULL. Thread: set-up
 * only. */
softsim_status ss_model_create(const ss_model_class *model_class, const ss_model_plan *plan,
                               ss_model **out_model, softsim_error *error);

/* Begins a step of `dt` s: good until something is found. False where there is none to make.
 * RT-safe.
 */
static inline bool ss_model_begin(softsim_verdict *verdict, const char **reason, double dt)
{
    if (*verdict == SOFTSIM_VERDICT_FAULT || !(dt > 0.0)) {
        return false;
    }
    *verdict = SOFTSIM_VERDICT_GOOD;
    *reason = "";
    return true;
}

/* Where a tool stands after a step that went `travelled` of the way. RT-safe. */
void ss_model_reached(const ss_model_tool *tool, double travelled, ss_tool_pose *out);

/* The parameter of that name; NULL. Thread: any. */
const ss_param_row *ss_model_find_row(const ss_model_class *model, const char *name);

/* The models built into this program. Thread: any. */
const ss_model_class *ss_model_find(const char *name);
enum { SS_MAX_MODELS = 16 }; /* more than there are: the table checks it */
const ss_model_class *const *ss_model_table(int32_t *out_count);
