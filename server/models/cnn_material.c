/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn_energy.h"
/*
 * Parameters of cnn-energy: the table that the scene reads, values a node from it, and everything
 * about them and the plan that is refused. All faults are named in one go, with node numbers.
 *
 * Mass, damping and rest stiffness are densities times the node's area S_i by default: a body
 * then keeps its behaviour when its mesh is refined. Given per node they are taken as they stand.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

/* ---- the table ---------------------------------------------------------------------------- */

#define ABSENT ((double)NAN)

const ss_param_row ss_cnn_rows_table[SS_CNN_ROW_COUNT] = {
    [SS_CNN_MODULUS_J] = {.name = "modulus_j",
                          .kind = SS_PARAM_NUMBER,
                          .max = 1e9,
                          .exclusive_min = true,
                          .is_live = true,
                          .fallback = ABSENT,
                          .help = "stiffness of the network (J), the same on every mesh; this or "
                                  "modulus_n_per_m"},
    [SS_CNN_MODULUS_N_PER_M] = {.name = "modulus_n_per_m",
                                .kind = SS_PARAM_NUMBER,
                                .max = 1e12,
                                .exclusive_min = true,
                                .is_live = true,
                                .fallback = ABSENT,
                                .help = "membrane modulus E; tools then take E times the median "
                                        "Qhat of this mesh"},
    [SS_CNN_PRETENSION_J] = {.name = "pretension_j",
                             .kind = SS_PARAM_NUMBER,
                             .max = 1e9,
                             .is_live = true,
                             .help = "tension of the surface at rest (J), balanced by what it "
                                     "encloses; recommended for closed bodies that are fixed"},
    [SS_CNN_ENCLOSED_BULK_PA] = {.name = "enclosed_bulk_pa",
                                 .kind = SS_PARAM_NUMBER,
                                 .max = 1e12,
                                 .help = "resistance of the enclosed volume to change; closed "
                                         "bodies that are fixed"},
    [SS_CNN_RHO] = {.name = "rho",
                    .kind = SS_PARAM_FIELD,
                    .max = 1e12,
                    .exclusive_min = true,
                    .fallback = 1.0,
                    .help = "constitutive coefficient of the network; only its ratios matter "
                            "unless it saturates"},
    [SS_CNN_PER_AREA] = {.name = "per_area",
                         .kind = SS_PARAM_BOOL,
                         .max = 1.0,
                         .fallback = 1.0,
                         .help = "mass, damping and rest stiffness per area, times the node's "
                                 "area; false: per node as given"},
    [SS_CNN_AREA_DENSITY] = {.name = "area_density_kg_m2",
                             .kind = SS_PARAM_FIELD,
                             .max = 1e9,
                             .exclusive_min = true,
                             .fallback = ABSENT,
                             .help = "mass per area"},
    [SS_CNN_AREA_DAMPING] = {.name = "damping_n_s_per_m3",
                             .kind = SS_PARAM_FIELD,
                             .max = 1e12,
                             .fallback = ABSENT,
                             .help = "damping per area (gamma)"},
    [SS_CNN_AREA_REST_STIFFNESS] = {.name = "rest_stiffness_n_per_m3",
                                    .kind = SS_PARAM_FIELD,
                                    .max = 1e15,
                                    .fallback = ABSENT,
                                    .help = "stiffness per area with which a node returns to its "
                                            "place at rest (ks)"},
    [SS_CNN_MASS] = {.name = "mass_kg",
                     .kind = SS_PARAM_FIELD,
                     .max = 1e9,
                     .exclusive_min = true,
                     .fallback = ABSENT,
                     .help = "mass of a node, with per_area: false"},
    [SS_CNN_DAMPING] = {.name = "damping_n_s_per_m",
                        .kind = SS_PARAM_FIELD,
                        .max = 1e12,
                        .fallback = ABSENT,
                        .help = "damping of a node, with per_area: false"},
    [SS_CNN_REST_STIFFNESS] = {.name = "rest_stiffness_n_per_m",
                               .kind = SS_PARAM_FIELD,
                               .max = 1e15,
                               .fallback = ABSENT,
                               .help = "rest stiffness of a node, with per_area: false"},
    [SS_CNN_SATURATION] = {.name = "saturation",
                           .kind = SS_PARAM_NUMBER,
                           .max = 1e30,
                           .exclusive_min = true,
                           .fallback = ABSENT,
                           .help = "largest output K of a cell, in the potential's unit; absent: "
                                   "none"},
    [SS_CNN_SOURCE] = {.name = "source",
                       .kind = SS_PARAM_CHOICE,
                       .max = 1.0,
                       .choices = "footprint|contact",
                       .help = "where energy enters: on every cell under a tool or of a load, or "
                               "on the one contact cell"},
    [SS_CNN_SOLVER] = {.name = "solver",
                       .kind = SS_PARAM_CHOICE,
                       .max = 1.0,
                       .choices = "equilibrium|relaxation",
                       .help = "the network settled, or in its own time from the first touch on"},
    [SS_CNN_RELAXATION_STEPS] = {.name = "relaxation_steps",
                                 .kind = SS_PARAM_INTEGER,
                                 .min = 1.0,
                                 .max = 10000.0,
                                 .fallback = 10.0,
                                 .help = "steps of the network's own time a sub-step, with solver: "
                                         "relaxation"},
};

/* ---- values a node ------------------------------------------------------------------------ */

/* The first few numbers of a fault: "3, 17, 20". */
typedef struct number_list {
    int32_t count;
    char text[96];
} number_list;

static void add_number(number_list *list, int32_t number)
{
    if (list->count++ < 5) {
        const size_t used = strlen(list->text);
        snprintf(list->text + used, sizeof list->text - used, "%s%d", used > 0 ? ", " : "", number);
    }
}

static double value_at(const ss_param_value *value, int32_t node)
{
    return value->per_node ? value->per_node[node] : value->number;
}

/* One field into `out`, times `scale[i]` where that is given. Nodes without a triangle get 0. */
static void fill_field(const ss_model_plan *plan, int row, const double *area, bool is_scaled,
                       double *out, softsim_error *error)
{
    const ss_param_row *spec = &ss_cnn_rows_table[row];
    number_list bad = {0};
    for (int32_t i = 0; i < plan->mesh->node_count; ++i) {
        const double value = value_at(&plan->param[row], i);
        const bool is_good = isfinite(value) && value <= spec->max &&
                             (spec->exclusive_min ? value > spec->min : value >= spec->min);
        const bool is_used = area[i] >= 0.0;
        if (is_used && !is_good) {
            add_number(&bad, i);
        }
        out[i] = !is_used ? 0.0 : is_scaled ? value * area[i] : value;
    }
    if (bad.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: %s must be %s 0 and at most %g at every node; %d nodes are "
                          "not (first %s)",
                          spec->name, spec->exclusive_min ? "greater than" : "at least", spec->max,
                          bad.count, bad.text);
    }
}

/* Areas S_i; -1 for nodes without a triangle. */
static double *node_areas(const ss_mesh *mesh)
{
    double *area = ss_memory_get((size_t)mesh->node_count, sizeof *area);
    for (int32_t i = 0; area && i < mesh->node_count; ++i) {
        area[i] = -1.0;
    }
    for (int32_t t = 0; area && t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        double u[3], v[3], n[3];
        ss_sub3(u, mesh->position[c[1]], mesh->position[c[0]]);
        ss_sub3(v, mesh->position[c[2]], mesh->position[c[0]]);
        ss_cross3(n, u, v);
        for (int k = 0; k < 3; ++k) {
            area[c[k]] = (area[c[k]] < 0.0 ? 0.0 : area[c[k]]) + ss_norm3(n) / 6.0;
        }
    }
    return area;
}

static void check_areas(const ss_model_plan *plan, const double *area, bool is_per_area,
                        softsim_error *error)
{
    number_list loose = {0}, flat = {0};
    for (int32_t i = 0; i < plan->mesh->node_count; ++i) {
        if (area[i] < 0.0 && plan->mesh->tetrahedron_count == 0) {
            add_number(&loose, i);
        }
        if (area[i] == 0.0 && is_per_area) {
            add_number(&flat, i);
        }
    }
    if (loose.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "cnn-energy: %d nodes belong to no triangle (first %s): remove them",
                          loose.count, loose.text);
    }
    if (flat.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "cnn-energy: %d nodes have only triangles without area (first %s), hence "
                          "no mass: repair the mesh or give masses with per_area: false",
                          flat.count, flat.text);
    }
}

/* Exactly the three rows of the chosen kind must be given. */
static bool rows_are_given(const ss_model_plan *plan, bool is_per_area, softsim_error *error)
{
    static const int area_row[3] = {SS_CNN_AREA_DENSITY, SS_CNN_AREA_DAMPING,
                                    SS_CNN_AREA_REST_STIFFNESS};
    static const int node_row[3] = {SS_CNN_MASS, SS_CNN_DAMPING, SS_CNN_REST_STIFFNESS};
    bool is_good = true;
    for (int k = 0; k < 3; ++k) {
        const int wanted = is_per_area ? area_row[k] : node_row[k];
        const int other = is_per_area ? node_row[k] : area_row[k];
        if (!plan->param[wanted].is_given) {
            softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                              "cnn-energy: %s is missing (per_area is %s)",
                              ss_cnn_rows_table[wanted].name, is_per_area ? "true" : "false");
            is_good = false;
        }
        if (plan->param[other].is_given) {
            softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                              "cnn-energy: %s does not go with per_area: %s; give %s",
                              ss_cnn_rows_table[other].name, is_per_area ? "true" : "false",
                              ss_cnn_rows_table[wanted].name);
            is_good = false;
        }
    }
    return is_good;
}

static void read_numbers(const ss_model_plan *plan, ss_cnn_material *material, softsim_error *error)
{
    const ss_param_value *param = plan->param;
    const bool has_energy = param[SS_CNN_MODULUS_J].is_given;
    const bool has_modulus = param[SS_CNN_MODULUS_N_PER_M].is_given;
    if (has_energy == has_modulus) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: give modulus_j or modulus_n_per_m%s",
                          has_energy ? ", not both" : "");
    }
    material->is_modulus_energy = has_energy;
    material->modulus = param[has_energy ? SS_CNN_MODULUS_J : SS_CNN_MODULUS_N_PER_M].number;
    material->pretension = param[SS_CNN_PRETENSION_J].number;
    material->bulk = param[SS_CNN_ENCLOSED_BULK_PA].number;
    const ss_param_row *steps = &ss_cnn_rows_table[SS_CNN_RELAXATION_STEPS];
    if (param[SS_CNN_RELAXATION_STEPS].is_given && param[SS_CNN_SOLVER].number == 0.0) {
        softsim_error_add(
            error, SOFTSIM_ERROR_SCENE,
            "cnn-energy: relaxation_steps goes with solver: relaxation; the solver is "
            "equilibrium");
    }
    if (!(param[SS_CNN_RELAXATION_STEPS].number >= steps->min &&
          param[SS_CNN_RELAXATION_STEPS].number <= steps->max)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: relaxation_steps must be %g to %g", steps->min, steps->max);
    }
    const double k = param[SS_CNN_SATURATION].number;
    material->saturation = param[SS_CNN_SATURATION].is_given ? k : (double)INFINITY;
    if (((has_energy || has_modulus) && !(material->modulus > 0.0 && material->modulus <= 1e12)) ||
        !(material->pretension >= 0.0 && material->pretension <= 1e9) ||
        !(material->bulk >= 0.0 && material->bulk <= 1e12) || !(material->saturation > 0.0)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: modulus and saturation must be greater than 0, pretension_j "
                          "and enclosed_bulk_pa at least 0, all of them finite");
    }
}

softsim_status ss_cnn_material_create(const ss_model_plan *plan, ss_cnn_material *out_material,
                                      softsim_error *error)
{
    const size_t n = (size_t)plan->mesh->node_count;
    const bool is_per_area = plan->param[SS_CNN_PER_AREA].number != 0.0;
    ss_cnn_material material = {.mass = ss_memory_get(n, sizeof(double)),
                                .damping = ss_memory_get(n, sizeof(double)),
                                .rest_stiffness = ss_memory_get(n, sizeof(double)),
                                .rho = ss_memory_get(n, sizeof(double))};
    double *area = node_areas(plan->mesh);
    *out_material = material;
    if (!material.mass || !material.damping || !material.rest_stiffness || !material.rho || !area) {
        ss_memory_free(area);
        return SOFTSIM_ERROR_MEMORY;
    }
    const int32_t before = error ? error->fault_count : 0;
    read_numbers(plan, &material, error);
    check_areas(plan, area, is_per_area, error);
    fill_field(plan, SS_CNN_RHO, area, false, material.rho, error);
    if (rows_are_given(plan, is_per_area, error)) {
        fill_field(plan, is_per_area ? SS_CNN_AREA_DENSITY : SS_CNN_MASS, area, is_per_area,
                   material.mass, error);
        fill_field(plan, is_per_area ? SS_CNN_AREA_DAMPING : SS_CNN_DAMPING, area, is_per_area,
                   material.damping, error);
        fill_field(plan, is_per_area ? SS_CNN_AREA_REST_STIFFNESS : SS_CNN_REST_STIFFNESS, area,
                   is_per_area, material.rest_stiffness, error);
    }
    for (size_t i = 0; i < n; ++i) {
        material.rho[i] = area[i] < 0.0 ? 1.0 : material.rho[i];
    }
    ss_memory_free(area);
    *out_material = material;
    return error && error->fault_count > before ? SOFTSIM_ERROR_SCENE : SOFTSIM_OK;
}

void ss_cnn_material_fini(ss_cnn_material *material)
{
    ss_memory_free(material->mass);
    ss_memory_free(material->damping);
    ss_memory_free(material->rest_stiffness);
    ss_memory_free(material->rho);
    *material = (ss_cnn_material){0};
}

/* ---- the plan ----------------------------------------------------------------------------- */

/* Is axis `k` of node `i` of a prescribed set driven? */
static bool is_driven(const ss_prescribed *set, int32_t i, int k)
{
    return set->axis[k] && isfinite(set->displacement[i][k]);
}

static bool nodes_are_valid(const ss_model_plan *plan, const int32_t *node, int32_t count,
                            const char *what, int32_t which, softsim_error *error)
{
    number_list bad = {0};
    for (int32_t k = 0; k < count; ++k) {
        if (node[k] < 0 || node[k] >= plan->mesh->node_count) {
            add_number(&bad, node[k]);
        }
    }
    if (count <= 0 || bad.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: %s %d names %d nodes, %d of them not in the mesh%s%s", what,
                          which, count, bad.count, bad.count > 0 ? ": " : "", bad.text);
    }
    return count > 0 && bad.count == 0;
}

static void check_load(const ss_model_plan *plan, const ss_load *load, int32_t which,
                       softsim_error *error)
{
    if (!nodes_are_valid(plan, load->node, load->node_count, "load", which, error)) {
        return;
    }
    if (!ss_is_finite(load->force, 3) || !isfinite(load->pressure) || !isfinite(load->from) ||
        isnan(load->to) || !(load->ramp >= 0.0)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: load %d has a force, pressure or time that is not a number",
                          which);
    }
    number_list fixed = {0};
    for (int32_t k = 0; !load->is_pressure && k < load->node_count; ++k) {
        if ((plan->fixed[load->node[k]] & 7) == 7) {
            add_number(&fixed, load->node[k]);
        }
    }
    if (fixed.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: load %d pushes %d fixed nodes (first %s), whose cells are "
                          "held at zero: take them out",
                          which, fixed.count, fixed.text);
    }
}

static void check_prescribed(const ss_model_plan *plan, int32_t which, uint8_t *taken,
                             softsim_error *error)
{
    const ss_prescribed *set = &plan->prescribed[which];
    if (!nodes_are_valid(plan, set->node, set->node_count, "prescribed set", which, error)) {
        return;
    }
    number_list clash = {0};
    for (int32_t i = 0; i < set->node_count; ++i) {
        bool is_clash = false;
        for (int k = 0; k < 3; ++k) {
            const uint8_t bit = (uint8_t)(1 << k);
            if (is_driven(set, i, k)) {
                is_clash = is_clash || (taken[set->node[i]] & bit) != 0;
                taken[set->node[i]] = (uint8_t)(taken[set->node[i]] | bit);
            }
        }
        if (is_clash) {
            add_number(&clash, set->node[i]);
        }
    }
    if (clash.count > 0) {
        softsim_error_add(
            error, SOFTSIM_ERROR_SCENE,
            "cnn-energy: prescribed set %d drives %d nodes (first %s) along axes that "
            "are fixed or driven already",
            which, clash.count, clash.text);
    }
    if (!isfinite(set->from) || !(set->ramp >= 0.0)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: prescribed set %d has a time that is not a number", which);
    }
}

softsim_status ss_cnn_plan_check(const ss_model_plan *plan, const ss_cnn_material *material,
                                 softsim_error *error)
{
    const int32_t before = error ? error->fault_count : 0;
    uint8_t *taken = ss_memory_get((size_t)plan->mesh->node_count, sizeof *taken);
    if (!taken) {
        return SOFTSIM_ERROR_MEMORY;
    }
    memcpy(taken, plan->fixed, (size_t)plan->mesh->node_count);
    for (int32_t k = 0; k < plan->load_count; ++k) {
        check_load(plan, &plan->load[k], k, error);
    }
    for (int32_t k = 0; k < plan->prescribed_count; ++k) {
        check_prescribed(plan, k, taken, error);
    }
    ss_memory_free(taken);
    if (!ss_is_finite(plan->gravity, 3) || !(plan->step > 0.0) || plan->max_substeps < 1) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: gravity must be finite, the step greater than 0 and "
                          "max_substeps at least 1");
    }
    const bool is_sound = !error || error->fault_count == before;
    const bool is_held = is_sound && ss_cnn_plan_is_held(plan);
    if (is_sound && !is_held && (material->pretension > 0.0 || material->bulk > 0.0)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: pretension_j and enclosed_bulk_pa need at least three fixed "
                          "nodes that are not in a line: fix some, or set both to 0");
    }
    if (material->bulk > 0.0 && !plan->mesh->is_closed) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: enclosed_bulk_pa needs a closed surface");
    }
    return error && error->fault_count > before ? SOFTSIM_ERROR_SCENE : SOFTSIM_OK;
}

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

bool ss_cnn_plan_is_held(const ss_model_plan *plan)
{
    const ss_mesh *mesh = plan->mesh;
    double centre[3] = {0.0}, size = 0.0, matrix[6][6] = {{0.0}};
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        ss_madd3(centre, centre, 1.0 / mesh->node_count, mesh->position[i]);
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        double r[3];
        ss_sub3(r, mesh->position[i], centre);
        size = fmax(size, ss_norm3(r));
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        double r[3];
        ss_sub3(r, mesh->position[i], centre);
        ss_scale3(r, r, 1.0 / size);
        add_constraint(matrix, r, plan->fixed[i]);
    }
    for (int32_t p = 0; p < plan->prescribed_count; ++p) {
        const ss_prescribed *set = &plan->prescribed[p];
        for (int32_t i = 0; i < set->node_count; ++i) {
            double r[3];
            ss_sub3(r, mesh->position[set->node[i]], centre);
            ss_scale3(r, r, 1.0 / size);
            const int mask = (is_driven(set, i, 0) ? 1 : 0) | (is_driven(set, i, 1) ? 2 : 0) |
                             (is_driven(set, i, 2) ? 4 : 0);
            add_constraint(matrix, r, (uint8_t)mask);
        }
    }
    return is_full_rank(matrix);
}
