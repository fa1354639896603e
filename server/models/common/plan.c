/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/plan.h"
/* Loads, prescribed sets and supports of a plan. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#define GAIN_TIME 0.1 /* s, over which gains are added up */

void ss_number_list_add(ss_number_list *list, int32_t number)
{
    if (list->count++ < 5) {
        const size_t used = strlen(list->text);
        snprintf(list->text + used, sizeof list->text - used, "%s%d", used > 0 ? ", " : "", number);
    }
}

double ss_plan_node_value(const ss_param_value *value, int32_t node)
{
    return value->per_node ? value->per_node[node] : value->number;
}

double ss_plan_element_value(const ss_model_plan *plan, int row, int32_t e)
{
    const ss_param_value *value = &plan->param[row];
    const int32_t *c = plan->mesh->tetrahedron[e];
    const double *at = value->per_node;
    if (value->by_element) {
        return value->by_element[e];
    }
    return at ? 0.25 * ((at[c[0]] + at[c[1]]) + (at[c[2]] + at[c[3]])) : value->number;
}

static bool has_viscosity(const ss_model_plan *plan, const int row[3])
{
    bool is_any = false;
    for (int k = 0; k < 3; ++k) {
        const ss_param_value *value = &plan->param[row[k]];
        is_any = is_any || value->per_node || value->by_element || value->number > 0.0;
    }
    return is_any;
}

void ss_plan_viscosity(const ss_model_plan *plan, const int row[3], const double *lambda,
                       const double *mu, ss_arena *arena, double **out_phi, double **out_psi,
                       double *out_time)
{
    const size_t n = (size_t)plan->mesh->tetrahedron_count;
    const double time = plan->param[row[2]].number;
    const bool is_any = has_viscosity(plan, row);
    double *phi = is_any ? ss_arena_get(arena, n, sizeof *phi) : NULL;
    double *psi = is_any ? ss_arena_get(arena, n, sizeof *psi) : NULL;
    *out_phi = phi;
    *out_psi = psi;
    *out_time = 0.0;
    for (size_t e = 0; phi && psi && e < n; ++e) {
        phi[e] = ss_plan_element_value(plan, row[0], (int32_t)e) + time * fmax(lambda[e], 0.0);
        psi[e] = ss_plan_element_value(plan, row[1], (int32_t)e) + time * mu[e];
        const double dilatation = (phi[e] + 2.0 / 3.0 * psi[e]) / (lambda[e] + 2.0 / 3.0 * mu[e]);
        *out_time = fmax(*out_time, fmax(dilatation, psi[e] / mu[e]));
    }
}

bool ss_plan_is_prescribed(const ss_prescribed *set, int32_t i, int k)
{
    return set->axis[k] && isfinite(set->displacement[i][k]);
}

uint8_t ss_plan_driven_axes(const ss_prescribed *set, int32_t i)
{
    return (uint8_t)(ss_plan_is_prescribed(set, i, 0) | ss_plan_is_prescribed(set, i, 1) << 1 |
                     ss_plan_is_prescribed(set, i, 2) << 2);
}

double ss_plan_ramp(double from, double ramp, double time)
{
    if (time < from) {
        return 0.0;
    }
    return ramp > 0.0 ? fmin(1.0, (time - from) / ramp) : 1.0;
}

double ss_plan_load_factor(const ss_load *load, double time)
{
    return ss_load_pushes(load) && time < load->to ? ss_plan_ramp(load->from, load->ramp, time)
                                                   : 0.0;
}

/* ---- prescribed sets ---- */

void ss_prescribed_set_init(ss_prescribed_set *prescribed, const ss_prescribed *plan,
                            ss_arena *arena)
{
    prescribed->plan = plan;
    prescribed->from = ss_arena_get(arena, (size_t)plan->node_count, sizeof *prescribed->from);
    prescribed->to = ss_arena_get(arena, (size_t)plan->node_count, sizeof *prescribed->to);
}

double ss_plan_pool_gain(double pool, double gain, double most, double dt)
{
    return fmax(-most, pool * exp(-dt / GAIN_TIME) + gain);
}

void ss_prescribed_set_aim(ss_prescribed_set *prescribed, const ss_real *u, double time)
{
    const ss_prescribed *set = prescribed->plan;
    const double factor = ss_plan_ramp(set->from, set->ramp, time);
    for (int32_t i = 0; i < set->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            if (ss_plan_is_prescribed(set, i, k)) {
                prescribed->from[i][k] = (double)u[4 * (ptrdiff_t)set->node[i] + k];
                prescribed->to[i][k] = factor * set->displacement[i][k];
            }
        }
    }
}

double ss_prescribed_set_place(const ss_prescribed_set *prescribed, double path, double fraction,
                               double h, const double *mass, ss_real *u, ss_real *v)
{
    const ss_prescribed *set = prescribed->plan;
    double work = 0.0;
    for (int32_t i = 0; i < set->node_count; ++i) {
        const double half_mass = 0.5 * mass[set->node[i]];
        for (int k = 0; k < 3; ++k) {
            if (!ss_plan_is_prescribed(set, i, k)) {
                continue;
            }
            const ptrdiff_t at = 4 * (ptrdiff_t)set->node[i] + k;
            const double way = prescribed->to[i][k] - prescribed->from[i][k];
            const double before = (double)v[at];
            u[at] = (ss_real)(prescribed->from[i][k] + path * way);
            v[at] = h > 0.0 ? (ss_real)(way * fraction / h) : v[at];
            /* The support also pays for the change of velocity. */
            const double after = (double)v[at];
            work += half_mass * (after * after - before * before);
        }
    }
    return work;
}

/* ---- refusals ---- */

typedef struct checker {
    const ss_model_plan *plan;
    const char *name;    /* of the model */
    const double *size;  /* a value a node, below 0 where there is nothing to push or hold */
    const char *outside; /* what is said of such nodes in a load or a set; NULL: nothing */
    softsim_error *error;
} checker;

static bool nodes_are_valid(const checker *check, const int32_t *node, int32_t count,
                            const char *what, int32_t which)
{
    ss_number_list bad = {0};
    for (int32_t k = 0; k < count; ++k) {
        if (node[k] < 0 || node[k] >= check->plan->mesh->node_count) {
            ss_number_list_add(&bad, node[k]); /* no node: the file has no number for it */
        }
    }
    if (count <= 0 || bad.count > 0) {
        softsim_error_add(check->error, SOFTSIM_ERROR_SCENE,
                          "%s: %s %d names %d nodes, %d of them not in the mesh%s%s", check->name,
                          what, which, count, bad.count, bad.count > 0 ? ": " : "", bad.text);
    }
    return count > 0 && bad.count == 0;
}

static void check_load(const checker *check, int32_t which)
{
    const ss_model_plan *plan = check->plan;
    const ss_load *load = &plan->load[which];
    if (!nodes_are_valid(check, load->node, load->node_count, "load", which)) {
        return;
    }
    if (!ss_is_finite(load->force, 3) || !isfinite(load->pressure) || !isfinite(load->from) ||
        isnan(load->to) || !(load->ramp >= 0.0)) {
        softsim_error_add(check->error, SOFTSIM_ERROR_SCENE,
                          "%s: load %d has a force, pressure or time that is not a number",
                          check->name, which);
    }
    ss_number_list fixed = {0}, outside = {0};
    for (int32_t k = 0; !load->is_pressure && k < load->node_count; ++k) {
        if ((plan->fixed[load->node[k]] & 7) == 7) {
            ss_number_list_add(&fixed, ss_mesh_file_node(plan->mesh, load->node[k]));
        }
        if (check->size[load->node[k]] < 0.0) {
            ss_number_list_add(&outside, ss_mesh_file_node(plan->mesh, load->node[k]));
        }
    }
    if (outside.count > 0 && check->outside) {
        softsim_error_add(check->error, SOFTSIM_ERROR_SCENE,
                          "%s: load %d pushes %d nodes (first %s) %s", check->name, which,
                          outside.count, outside.text, check->outside);
    }
    if (fixed.count > 0) {
        softsim_error_add(check->error, SOFTSIM_ERROR_SCENE,
                          "%s: load %d pushes %d fixed nodes (first %s), which nothing moves: "
                          "take them out",
                          check->name, which, fixed.count, fixed.text);
    }
}

/* `taken`: the axes of every node that are fixed or prescribed so far. */
static void check_prescribed(const checker *check, int32_t which, uint8_t *taken)
{
    const ss_model_plan *plan = check->plan;
    const ss_prescribed *set = &plan->prescribed[which];
    if (!nodes_are_valid(check, set->node, set->node_count, "prescribed set", which)) {
        return;
    }
    ss_number_list clash = {0}, outside = {0};
    for (int32_t i = 0; i < set->node_count; ++i) {
        bool is_clash = false;
        if (check->size[set->node[i]] < 0.0) {
            ss_number_list_add(&outside, ss_mesh_file_node(plan->mesh, set->node[i]));
        }
        for (int k = 0; k < 3; ++k) {
            const uint8_t bit = (uint8_t)(1 << k);
            if (ss_plan_is_prescribed(set, i, k)) {
                is_clash = is_clash || (taken[set->node[i]] & bit) != 0;
                taken[set->node[i]] = (uint8_t)(taken[set->node[i]] | bit);
            }
        }
        if (is_clash) {
            ss_number_list_add(&clash, ss_mesh_file_node(plan->mesh, set->node[i]));
        }
    }
    /* Beside others they follow; alone they would stay, and nobody would be told. */
    if (outside.count == set->node_count && check->outside) {
        softsim_error_add(check->error, SOFTSIM_ERROR_SCENE,
                          "%s: prescribed set %d drives nothing: its %d nodes (first %s) are all "
                          "among those %s",
                          check->name, which, outside.count, outside.text, check->outside);
    }
    if (clash.count > 0) {
        softsim_error_add(check->error, SOFTSIM_ERROR_SCENE,
                          "%s: prescribed set %d drives %d nodes (first %s) along axes that are "
                          "fixed or prescribed already",
                          check->name, which, clash.count, clash.text);
    }
    if (!isfinite(set->from) || !(set->ramp >= 0.0)) {
        softsim_error_add(check->error, SOFTSIM_ERROR_SCENE,
                          "%s: prescribed set %d has a time that is not a number", check->name,
                          which);
    }
}

/* What is held of each body of the mesh. */
typedef struct plan_bodies {
    int32_t *of;            /* of a node; -1: none */
    double (*matrix)[6][6]; /* of a body: what is held against each rigid motion */
    bool *is_judged;        /* of a body */
    double centre[3], size; /* of them all */
} plan_bodies;

/* Adds the constraint rows (axis, r x axis) of the axes in `mask` to the 6 x 6 normal matrix. */
static void add_constraint(double matrix[6][6], const double r[3], uint8_t mask)
{
    for (int k = 0; k < 3; ++k) {
        if ((mask & (1 << k)) == 0) {
            continue;
        }
        double row[6] = {0.0}, axis[3] = {0.0}, moment[3];
        axis[k] = 1.0;
        ss_cross3(moment, r, axis);
        row[k] = 1.0;
        ss_copy3(row + 3, moment);
        for (int a = 0; a < 6; ++a) {
            for (int b = 0; b < 6; ++b) {
                matrix[a][b] += row[a] * row[b];
            }
        }
    }
}

/* Rank 6 by elimination with full pivoting. */
static bool is_full_rank(double matrix[6][6])
{
    double largest = 0.0;
    for (int step = 0; step < 6; ++step) {
        int row = step;
        for (int a = step; a < 6; ++a) {
            row = matrix[a][a] > matrix[row][row] ? a : row;
        }
        for (int b = 0; b < 6; ++b) {
            const double t = matrix[step][b];
            matrix[step][b] = matrix[row][b];
            matrix[row][b] = t;
        }
        for (int a = 0; a < 6; ++a) {
            const double t = matrix[a][step];
            matrix[a][step] = matrix[a][row];
            matrix[a][row] = t;
        }
        const double pivot = matrix[step][step];
        largest = pivot > largest ? pivot : largest;
        if (!(pivot > 1e-8 * largest)) {
            return false;
        }
        for (int a = step + 1; a < 6; ++a) {
            const double factor = matrix[a][step] / pivot;
            for (int b = step; b < 6; ++b) {
                matrix[a][b] -= factor * matrix[step][b];
            }
        }
    }
    return true;
}

/* Adds what is given along the axes `mask` of node i to the matrix of its body. */
static void add_held(const plan_bodies *bodies, const ss_mesh *mesh, int32_t i, uint8_t mask)
{
    double r[3];
    if (bodies->of[i] >= 0) {
        ss_sub3(r, mesh->position[i], bodies->centre);
        ss_scale3(r, r, 1.0 / bodies->size);
        add_constraint(bodies->matrix[bodies->of[i]], r, mask);
    }
}

/* Do the fixed and prescribed axes of nodes with a size stop every rigid motion of every body that
 * has such nodes? */
static bool is_held(const plan_bodies *bodies, const ss_model_plan *plan, const double *size_of)
{
    const ss_mesh *mesh = plan->mesh;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        add_held(bodies, mesh, i, size_of[i] >= 0.0 ? plan->fixed[i] : 0);
    }
    for (int32_t p = 0; p < plan->prescribed_count; ++p) {
        const ss_prescribed *set = &plan->prescribed[p];
        for (int32_t i = 0; i < set->node_count; ++i) {
            const int32_t node = set->node[i];
            add_held(bodies, mesh, node, size_of[node] >= 0.0 ? ss_plan_driven_axes(set, i) : 0);
        }
    }
    bool is_every = true;
    for (int32_t i = 0; i < mesh->node_count && is_every; ++i) {
        const int32_t body = bodies->of[i];
        if (body >= 0 && size_of[i] >= 0.0 && !bodies->is_judged[body]) {
            bodies->is_judged[body] = true;
            is_every = is_full_rank(bodies->matrix[body]);
        }
    }
    return is_every;
}

/* Each body of the mesh has to be held by itself. */
static softsim_status judge_held(const ss_model_plan *plan, const double *size_of,
                                 bool *out_is_held)
{
    const ss_mesh *mesh = plan->mesh;
    plan_bodies bodies = {.of = ss_memory_get((size_t)mesh->node_count, sizeof *bodies.of)};
    const int32_t count = bodies.of ? ss_mesh_find_bodies(mesh, bodies.of) : -1;
    if (count > 0) {
        bodies.matrix = ss_memory_get((size_t)count, sizeof *bodies.matrix);
        bodies.is_judged = ss_memory_get((size_t)count, sizeof *bodies.is_judged);
    }
    bodies.size = ss_mesh_radius(mesh, bodies.centre);
    const bool is_good = count == 0 || (bodies.matrix && bodies.is_judged);
    *out_is_held = is_good && count > 0 && is_held(&bodies, plan, size_of);
    SS_EACH(ss_memory_free, bodies.of, bodies.matrix, bodies.is_judged);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

softsim_status ss_plan_check(const ss_model_plan *plan, const char *name, const double *size,
                             const char *outside, bool *out_is_held, softsim_error *error)
{
    const checker check = {
        .plan = plan, .name = name, .size = size, .outside = outside, .error = error};
    const int32_t before = error ? error->fault_count : 0;
    const size_t n = (size_t)plan->mesh->node_count;
    uint8_t *taken = ss_memory_get(n, sizeof *taken);
    if (!taken) {
        return SOFTSIM_ERROR_MEMORY;
    }
    memcpy(taken, plan->fixed, n);
    for (int32_t k = 0; k < plan->load_count; ++k) {
        check_load(&check, k);
    }
    for (int32_t k = 0; k < plan->prescribed_count; ++k) {
        check_prescribed(&check, k, taken);
    }
    if (!ss_is_finite(plan->gravity, 3) || !(plan->step > 0.0) || plan->max_substeps < 1) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "%s: gravity must be finite, the step greater than 0 and max_substeps at "
                          "least 1",
                          name);
    }
    ss_memory_free(taken);
    const bool is_sound = !error || error->fault_count == before;
    *out_is_held = false;
    return is_sound ? judge_held(plan, size, out_is_held) : SOFTSIM_ERROR_SCENE;
}

/* ---- contact ---- */

int32_t ss_plan_tool_count(const ss_model_plan *plan)
{
    int32_t count = 0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        count += plan->tool[k].is_used;
    }
    return count;
}

double ss_plan_smallest_tool(const ss_model_plan *plan)
{
    double smallest = (double)INFINITY;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (plan->tool[k].is_used) {
            smallest = fmin(smallest, ss_shape_inradius(&plan->tool[k].shape));
        }
    }
    return smallest;
}

double ss_plan_working_stiffness(const ss_model_plan *plan, double radius)
{
    const double working = plan->working_force > 0.0 ? plan->working_force : 1.0;
    return working / (0.03 * radius * radius * radius);
}

double ss_plan_contact_stiffness(const ss_model_plan *plan, double stable, double radius)
{
    if (plan->contact_stiffness > 0.0) {
        return plan->contact_stiffness;
    }
    return fmin(stable, ss_plan_working_stiffness(plan, radius));
}

const char *ss_plan_contact_remedy(const ss_model_plan *plan, double stiffness, double radius)
{
    if (plan->contact_stiffness > 0.0) {
        return "raise contact.stiffness_n_per_m3, or lower haptic.max_force_n";
    }
    if (stiffness >= ss_plan_working_stiffness(plan, radius)) {
        return "raise contact.working_force_n, or lower haptic.max_force_n";
    }
    return "raise simulation.rate_hz or simulation.max_substeps, or lower haptic.max_force_n: no "
           "stiffer "
           "contact is stable with the sub-steps planned";
}

void ss_plan_say_substeps(const ss_model_plan *plan, double longest, const ss_notes *out)
{
    const double count = ceil(plan->step / longest);
    if (count > plan->max_substeps) {
        ss_note_warning(out, "simulation.max_substeps",
                        "a step of %.4g s needs %.0f sub-steps at rest, more than the %d of "
                        "simulation.max_substeps: slower than real time; raise it, the density or "
                        "the size of the smallest elements, or lower the stiffness",
                        plan->step, count, plan->max_substeps);
    } else if (count > 1.0) {
        ss_note_used(out, "sub-steps", "a step of %.4g s takes %.0f at rest", plan->step, count);
    }
}

/* ---- pressure ---- */

softsim_status ss_plan_pressure_triangles(const ss_model_plan *plan, const char *name,
                                          int32_t which, ss_arena *arena, int32_t **out_triangle,
                                          int32_t *out_count, softsim_error *error)
{
    const ss_mesh *mesh = plan->mesh;
    const ss_load *load = &plan->load[which];
    uint8_t *is_in = ss_memory_get((size_t)mesh->node_count, 1);
    int32_t *triangle = ss_arena_get(arena, (size_t)mesh->triangle_count, sizeof *triangle);
    *out_triangle = triangle;
    *out_count = 0;
    if (!is_in || !triangle) {
        ss_memory_free(is_in);
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t k = 0; k < load->node_count; ++k) {
        is_in[load->node[k]] = 1;
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        if (is_in[c[0]] && is_in[c[1]] && is_in[c[2]]) {
            triangle[(*out_count)++] = t;
        }
    }
    ss_memory_free(is_in);
    if (*out_count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "%s: load %d is a pressure, but no triangle has all its nodes in the "
                          "group",
                          name, which);
        return SOFTSIM_ERROR_SCENE;
    }
    return SOFTSIM_OK;
}

void ss_plan_add_pressure(const ss_mesh *mesh, int32_t count, const int32_t *triangle,
                          const ss_real *u, double pressure, ss_real *force)
{
    for (int32_t k = 0; k < count; ++k) {
        const int32_t *c = mesh->triangle[triangle[k]];
        double p[3][3], along[3], across[3], n[3];
        for (int a = 0; a < 3; ++a) {
            const ss_real *moved = u + 4 * (ptrdiff_t)c[a];
            ss_set3(p[a], mesh->position[c[a]][0] + (double)moved[0],
                    mesh->position[c[a]][1] + (double)moved[1],
                    mesh->position[c[a]][2] + (double)moved[2]);
        }
        ss_sub3(along, p[1], p[0]);
        ss_sub3(across, p[2], p[0]);
        ss_cross3(n, along, across);
        ss_scale3(n, n, -pressure / 6.0);
        for (int a = 0; a < 3; ++a) {
            for (int axis = 0; axis < 3; ++axis) {
                force[4 * (ptrdiff_t)c[a] + axis] += (ss_real)n[axis];
            }
        }
    }
}
