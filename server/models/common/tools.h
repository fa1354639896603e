/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The tools of a model and the surface that they touch: what every model does with them in the same
 * way. Where they are in an outer step, what the penalty and the grasp of each press and store, how
 * stiff both are, and what of it the hand is told.
 *
 * A tool presses with the penalty of its samples and the springs of its grasp, one potential of
 * `penalty` + share x square J (contact.h, grasp.h). Its stiffness is K_contact: C x of a motion x
 * of the nodes, its rows' bounds D, and c, the force on the nodes for a unit motion of the tool
 * along n, k_cc that on the tool. Arrays are quads of the surface's nodes. Where the scene has
 * friction a tool that holds nothing also rubs (contact/friction.c): part of its force and
 * stiffness, but not of the potential; what it loses is booked when a place is kept. Models keep
 * what is their own of a tool beside it, under the same number. Memory: the arena's, but for
 * touches and surface, which ss_tools_fini releases. Thread: create, open and fini set-up only; the
 * rest by the simulation thread, RT-safe.
 */
#include "models/common/grasp.h"
#include "rt/note.h"

typedef struct ss_tool {
    bool is_used; /* has a row in the scene */
    const ss_shape *shape;
    ss_contact_query *query;
    double radius;          /* R, m: a sub-step goes a share of it */
    double delta;           /* m, reach of the weights */
    double stiffness;       /* kc, N/m^3 */
    double rest_felt;       /* N/m, of the contact a tenth of R deep and the body at rest */
    double rest_compliance; /* m/N, of that body alone */
    /* state */
    bool is_present, was_touching;
    ss_tool_pose pose;     /* where the forces below were evaluated */
    ss_tool_pose from, to; /* of the outer step */
    double rotation[3];    /* rotation vector from `from` to `to` */
    ss_grasp grasp;
    double force[3], torque[3]; /* on the tool */
    double penalty;             /* J */
    bool has_friction;
    double friction[3], friction_torque[3]; /* of force and torque, on the tool */
    ss_friction_energy rub;                 /* of the friction */
    double felt;                            /* N/m, last in contact, */
    double along[3];                        /* along this, in the tool's frame; 0: not in contact */
    double compliance;                      /* m/N, of the body alone: then, or at rest */
    double impulse[3];                      /* N s, of `force` over the end of the step, */
    double friction_impulse[3];             /* of that, the friction's */
    double span;                            /* s: and how long that was */
} ss_tool;

typedef struct ss_tools {
    ss_tool tool[SOFTSIM_MAX_PROBES];
    ss_surface *surface;     /* NULL without tools */
    const double (*rest)[3]; /* of its nodes, m */
    int32_t node_count;
} ss_tools;

/* ---- set-up ---- */

/* The surface of `mesh` for the plan's tools; nothing without a tool. */
softsim_status ss_tools_create(ss_tools *tools, const ss_mesh *mesh, const ss_model_plan *plan,
                               softsim_error *error);
/* Tool `index` of the plan against it; radius, delta and stiffness are set. */
softsim_status ss_tools_open(ss_tools *tools, const ss_model_plan *plan, int index,
                             ss_arena *arena);
void ss_tools_fini(ss_tools *tools);
/* Nothing is near any more, nothing is held or told. */
void ss_tools_reset(ss_tools *tools);
/* The body's `compliance` m/N, and what is felt of it with the contact a tenth of R deep. */
void ss_tool_set_rest_felt(ss_tool *tool, double compliance);
/* How deep it sinks in at haptic.max_force_n, m. */
double ss_tool_largest_depth(const ss_tool *tool, const ss_model_plan *plan);
/* What is wrong with tool `index` for its hand and its mesh of mean edge `edge` (m). */
void ss_tool_say_limits(const ss_tool *tool, int index, const ss_model_plan *plan, double edge,
                        const ss_notes *out);
/* Warns of a mesh whose corners the contact surface cuts off, as far as a tool can tell. */
void ss_tools_warn_rounded(const ss_tools *tools, const ss_model_plan *plan, const ss_notes *out);
/* Warns of a body that its supports do not hold, where a tool could push it. */
void ss_tools_warn_unheld(const ss_tools *tools, bool is_held, const ss_notes *out);

/* Is there friction, and of what? */
void ss_tools_say_friction(const ss_model_plan *plan, const ss_notes *out);
/* From what force on is a grasp torn? */
void ss_tools_say_grasp(const ss_model_plan *plan, const ss_notes *out);

/* ---- on the way ---- */

typedef enum ss_tool_news {
    SS_TOOL_KEPT,  /* it goes on from where it was, or stays away */
    SS_TOOL_MOVED, /* it came, or begins a little off its pose: forces are to be evaluated again */
    SS_TOOL_LOST   /* it left or jumped, and holds nothing any more; evaluate again */
} ss_tool_news;

/* Takes over where a tool goes in the outer step; `input` NULL: it is not there. */
ss_tool_news ss_tool_take(ss_tool *tool, const ss_model_tool *input);
/* Where a tool is at `path` (0..1) of its way; exactly at both ends, so that the next step finds it
 * there. */
void ss_tool_at(const ss_tool *tool, double path, ss_tool_pose *out);
bool ss_tools_is_any(const ss_tools *tools);
/* The force over the end of a step, piece by piece: a contact swings within a step, and the hand is
 * told the mean. Models that do not begin it tell the force at the end. */
void ss_tools_begin_mean(ss_tools *tools);
void ss_tools_add_mean(ss_tools *tools, double span);
/* Parts of the step in which no tool moves further than a quarter of its radius; at least 1. */
double ss_tools_parts(const ss_tools *tools);
/* The work of the tools for a whole step's way at the forces of the last evaluation, J. */
double ss_tools_work(const ss_tools *tools);
/* Grasps that were released fade by `h` seconds' worth; accept_fade then returns what they lost, J.
 */
void ss_tools_fade(ss_tools *tools, double h);
double ss_tools_accept_fade(ss_tools *tools);

/* The friction's anchors follow to the place of the last evaluation, as after each sub-step:
 * returns what was lost on the way, J. */
double ss_tools_keep_friction(ss_tools *tools);
/* What keeping them there would lose, J. */
double ss_tools_friction_loss(const ss_tools *tools);

/* ---- penalty and grasp ---- */

/* Evaluates at `pose` and displacements u: the tool's force is set, the nodes' added to `force`
 * (NULL: the penalty's are not wanted) and `grasp_force`. */
void ss_tools_press(const ss_tools *tools, ss_tool *tool, const ss_real *u, ss_real *force,
                    ss_real *grasp_force);
/* The friction that goes with the penalty just evaluated, added to both; `beside` (N): what pushes
 * the tool beside the penalty and presses it to the tissue, too; 0: nothing. */
void ss_tool_rub(ss_tool *tool, const double penalty[3], const double beside[3], ss_real *force);
static inline bool ss_tool_is_touching(const ss_tool *tool)
{
    return tool->penalty > 0.0 || tool->grasp.count > 0;
}
/* J: penalty, grasp and what friction holds, at the last evaluation. */
double ss_tool_energy(const ss_tool *tool);
/* Of all that are present. */
double ss_tools_energy(const ss_tools *tools);
/* Adds D, N/m: of the step bound, and of the tangent, which has no steps (contact/query.c). */
void ss_tool_add_diagonal(const ss_tool *tool, double *diagonal);
void ss_tool_add_tangent_diagonal(const ss_tool *tool, double *diagonal);
/* Adds the force's change for motions x of the nodes, which is -C x. */
void ss_tool_add_change(const ss_tool *tool, const ss_real *x, ss_real *out);
/* Adds c to `push`; returns k_cc, N/m. */
double ss_tool_push(const ss_tool *tool, const double normal[3], ss_real *push);
/* In contact it feels `felt` N/m, the contact's own k_cc in series with the body. */
void ss_tool_set_felt(ss_tool *tool, double felt, double k_cc);
uint64_t ss_tool_hash_felt(const ss_tool *tool, uint64_t hash);

/* ---- felt contact ---- */

/* Tool `probe` with an empty set, or NULL where there is none present. */
ss_tool *ss_tools_find(ss_tools *tools, int32_t probe, ss_contact_set *out);
/* Fills the set at displacements u; true where it touches: its stiffness along out_along is to
 * be shared (ss_contact_set_share). Else it is that of the touch to come: the body's as felt last,
 * or at rest, and the contact's as deep as that goes. */
bool ss_tool_fill_contacts(ss_tool *tool, const ss_real *u, double near, ss_contact_set *out,
                           double out_along[3]);
