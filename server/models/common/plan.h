/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What every model reads out of a plan in the same way: viscosities, which axes are prescribed, how
 * much of a load acts, the patches under pressure, and what of loads, prescribed sets and times is
 * refused. Thread: set-up only where marked; the rest any thread, RT-safe.
 */
#include "models/model.h"
#include "rt/arena.h"
#include "rt/note.h"

/* The first few numbers of a fault, for its message: "3, 17, 20". */
typedef struct ss_number_list {
    int32_t count;
    char text[96];
} ss_number_list;
void ss_number_list_add(ss_number_list *list, int32_t number);

/* A parameter's value at a node. */
double ss_plan_node_value(const ss_param_value *value, int32_t node);

/* Viscosity of every tetrahedron (Pa s), by three rows of the model's: phi and psi as given and a
 * time T of stiffness damping: phi = phi_given + T max(lambda, 0), psi = psi_given + T mu. lambda,
 * mu: Pa, one an element. out_phi and out_psi are NULL where nothing is given, or memory is short;
 * out_time (s): the viscous stiffness is at most that times the elastic. Thread: set-up only. */
void ss_plan_viscosity(const ss_model_plan *plan, const int row[3], const double *lambda,
                       const double *mu, ss_arena *arena, double **out_phi, double **out_psi,
                       double *out_time);

/* The scene's value with which ss_plan_viscosity gives some that rounds away. */
#define SS_PLAN_PUT_BACK_VISCOSITY "model.viscosity_phi_pa_s=1e-30"

/* Does the set prescribe axis `k` of its node `i`? */
bool ss_plan_is_prescribed(const ss_prescribed *set, int32_t i, int k);
/* The prescribed axes of node `i` of the set: bit 0 x, 1 y, 2 z. */
uint8_t ss_plan_driven_axes(const ss_prescribed *set, int32_t i);
/* 0 before `from`, 1 from `from` + `ramp` on. */
double ss_plan_ramp(double from, double ramp, double time);
/* The share of a load that acts at `time`; of one that pushes nothing, 0. */
double ss_plan_load_factor(const ss_load *load, double time);

/* Energy from nowhere, added up over about a tenth of a second: `pool` (J) after a step of `dt`
 * seconds that made `gain` (J; a loss is negative). Of losses it remembers `most` (J); beyond
 * `most` the gain is to be said and taken out. However small a step's share is, it shows. RT-safe.
 */
double ss_plan_pool_gain(double pool, double gain, double most, double dt);

/* A prescribed set on its way through an outer step. */
typedef struct ss_prescribed_set {
    const ss_prescribed *plan;
    double (*from)[3], (*to)[3]; /* m: over the outer step, where an axis is prescribed */
} ss_prescribed_set;
/* Thread: set-up only. */
void ss_prescribed_set_init(ss_prescribed_set *prescribed, const ss_prescribed *plan,
                            ss_arena *arena);
/* From where its nodes are to where they belong at `time`. */
void ss_prescribed_set_aim(ss_prescribed_set *prescribed, const ss_real *u, double time);
/* Puts its nodes at `path` (0..1) of the way, moving so that they cover `fraction` of it in `h`
 * seconds (h = 0: velocities stay). Returns the work of the support for their change of velocity,
 * J. */
double ss_prescribed_set_place(const ss_prescribed_set *prescribed, double path, double fraction,
                               double h, const double *mass, ss_real *u, ss_real *v);

/* What is wrong with loads, prescribed sets, gravity, step and budget, all of it, each line begun
 * with `name`, the model's. `size`: a value a node, below 0 where the model has nothing that could
 * be pushed or held; `outside` is what a load on such nodes is refused with (NULL: it is not).
 * out_is_held: do the fixed and prescribed axes stop every rigid motion of every body? SOFTSIM_OK,
 * SOFTSIM_ERROR_SCENE or SOFTSIM_ERROR_MEMORY. Thread: set-up only. */
softsim_status ss_plan_check(const ss_model_plan *plan, const char *name, const double *size,
                             const char *outside, bool *out_is_held, softsim_error *error);

/* The triangles whose nodes are all in the group of load `which`, a pressure; none is refused.
 * Thread: set-up only. */
softsim_status ss_plan_pressure_triangles(const ss_model_plan *plan, const char *name,
                                          int32_t which, ss_arena *arena, int32_t **out_triangle,
                                          int32_t *out_count, softsim_error *error);
/* s: the step that a counted cost is for; a usual one where none is chosen yet. */
static inline double ss_plan_cost_step(const ss_model_plan *plan)
{
    return plan->step > 0.0 ? plan->step : 1e-3;
}

/* What a step takes of its counted cost, where the plan knows, else 1: for who plans as much work
 * as there is time for. */
static inline double ss_plan_yardstick(const ss_model_plan *plan)
{
    return plan->yardstick > 0.0 ? plan->yardstick : 1.0;
}
int32_t ss_plan_tool_count(const ss_model_plan *plan);
/* The largest sphere within the smallest tool's shape: its radius, m; infinite without a tool. */
double ss_plan_smallest_tool(const ss_model_plan *plan);
/* Contact stiffness (N/m^3) with which a tool of radius R (m) sinks in by a tenth of R at the
 * working force. */
double ss_plan_working_stiffness(const ss_model_plan *plan, double radius);
/* Contact stiffness (N/m^3) for a tool of radius R (m): as given, else `stable`, but no stiffer
 * than the working stiffness. */
double ss_plan_contact_stiffness(const ss_model_plan *plan, double stable, double radius);
/* What to do about a tool of radius R (m) that sinks in too far with this contact stiffness
 * (N/m^3): it depends on what limits the stiffness. Static text. */
const char *ss_plan_contact_remedy(const ss_model_plan *plan, double stiffness, double radius);

/* How many sub-steps of at most `longest` (s) a step takes, where it takes several. */
void ss_plan_say_substeps(const ss_model_plan *plan, double longest, const ss_notes *out);

/* Adds -p times a third of each triangle's area vector, as it lies displaced by `u`, to `force`. */
void ss_plan_add_pressure(const ss_mesh *mesh, int32_t count, const int32_t *triangle,
                          const ss_real *u, double pressure, ss_real *force);
