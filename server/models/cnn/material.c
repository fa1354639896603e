/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * Parameters of cnn-energy: the table that the scene reads, values a node from it, and everything
 * about them and the plan that is refused. All faults are named in one go, with node numbers.
 *
 * Mass, damping and rest stiffness are densities times the node's area S_i (in volumes its volume
 * V_i) by default: a body then keeps its behaviour when its mesh is refined. Given per node they
 * are taken as they stand.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "models/common/plan.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* ---- the table ---- */

const ss_param_row ss_cnn_rows_table[SS_CNN_ROW_COUNT] = {
    [SS_CNN_DOMAIN] = SS_PARAM(
        CHOICE, "domain",
        "where energy propagates: along the surface, or through the tetrahedra of a volume mesh",
        .range.max = 1.0, .choices = "surface|volume"),
    [SS_CNN_MODULUS_J] = SS_PARAM(NUMBER, "modulus_j",
                                  "stiffness of the network (J), the same on every mesh; this or "
                                  "modulus_n_per_m or modulus_pa",
                                  SS_ABOVE(0, 1e9), .is_live = true, .fallback = SS_ABSENT),
    [SS_CNN_MODULUS_N_PER_M] =
        SS_PARAM(NUMBER, "modulus_n_per_m",
                 "membrane modulus E; tools then take E times the median Qhat of this mesh",
                 SS_ABOVE(0, 1e12), .is_live = true, .fallback = SS_ABSENT),
    [SS_CNN_MODULUS_PA] =
        SS_PARAM(NUMBER, "modulus_pa",
                 "the network's modulus with domain: volume, not Young's modulus (fit it by "
                 "softsim-fit); tools then take it times the median Qhat of this mesh",
                 SS_ABOVE(0, 1e15), .is_live = true, .fallback = SS_ABSENT),
    [SS_CNN_PRETENSION_J] = SS_PARAM(NUMBER, "pretension_j",
                                     "tension of the surface at rest (J), balanced by what it "
                                     "encloses; recommended for closed bodies that are fixed",
                                     SS_FROM(0, 1e9), .is_live = true),
    [SS_CNN_ENCLOSED_BULK_PA] = SS_PARAM(
        NUMBER, "enclosed_bulk_pa",
        "resistance of the enclosed volume of each body to change; closed bodies that are fixed",
        SS_FROM(0, 1e12)),
    [SS_CNN_RHO] = SS_PARAM(
        FIELD, "rho",
        "constitutive coefficient of the network; only its ratios matter unless it saturates",
        SS_ABOVE(0, 1e12), .fallback = 1.0),
    [SS_CNN_RHO_DIRECTION] = SS_PARAM(FIELD, "rho_direction",
                                      "anisotropic, in place of rho: along the material direction "
                                      "(on a grid without one: along u)",
                                      SS_ABOVE(0, 1e12), .fallback = SS_ABSENT),
    [SS_CNN_RHO_ACROSS] =
        SS_PARAM(FIELD, "rho_across", "anisotropic: across the material direction",
                 SS_ABOVE(0, 1e12), .fallback = SS_ABSENT),
    [SS_CNN_MATERIAL_DIRECTION] = SS_PARAM(DIRECTION, "material_direction",
                                           "direction of rho_direction; on surfaces its projection "
                                           "counts, on a grid the nearer pair of sides",
                                           SS_FROM(0, 1.0), .fallback = SS_ABSENT),
    [SS_CNN_PER_AREA] = SS_PARAM(BOOL, "per_area",
                                 "mass, damping and rest stiffness per area, times the node's area "
                                 "(with domain: volume per volume); false: per node as given",
                                 SS_FROM(0, 1.0), .fallback = 1.0),
    [SS_CNN_AREA_DENSITY] = SS_PARAM(FIELD, "area_density_kg_m2", "mass per area", SS_ABOVE(0, 1e9),
                                     .fallback = SS_ABSENT),
    [SS_CNN_AREA_DAMPING] = SS_PARAM(FIELD, "damping_n_s_per_m3", "damping per area (gamma)",
                                     SS_FROM(0, 1e12), .fallback = SS_ABSENT),
    [SS_CNN_AREA_REST_STIFFNESS] =
        SS_PARAM(FIELD, "rest_stiffness_n_per_m3",
                 "stiffness per area with which a node returns to its place at rest (ks)",
                 SS_FROM(0, 1e15), .fallback = SS_ABSENT),
    [SS_CNN_VOLUME_DENSITY] =
        SS_PARAM(FIELD, "density_kg_m3", "mass per volume, with domain: volume", SS_ABOVE(0, 1e9),
                 .fallback = SS_ABSENT),
    [SS_CNN_VOLUME_DAMPING] =
        SS_PARAM(FIELD, "damping_n_s_per_m4", "damping per volume (gamma), with domain: volume",
                 SS_FROM(0, 1e15), .fallback = SS_ABSENT),
    [SS_CNN_VOLUME_REST_STIFFNESS] = SS_PARAM(FIELD, "rest_stiffness_n_per_m4",
                                              "stiffness per volume with which a node returns to "
                                              "its place at rest (ks), with domain: volume",
                                              SS_FROM(0, 1e18), .fallback = SS_ABSENT),
    [SS_CNN_MASS] = SS_PARAM(FIELD, "mass_kg", "mass of a node, with per_area: false",
                             SS_ABOVE(0, 1e9), .fallback = SS_ABSENT),
    [SS_CNN_DAMPING] =
        SS_PARAM(FIELD, "damping_n_s_per_m", "damping of a node, with per_area: false",
                 SS_FROM(0, 1e12), .fallback = SS_ABSENT),
    [SS_CNN_REST_STIFFNESS] =
        SS_PARAM(FIELD, "rest_stiffness_n_per_m", "rest stiffness of a node, with per_area: false",
                 SS_FROM(0, 1e15), .fallback = SS_ABSENT),
    [SS_CNN_SATURATION] = SS_PARAM(
        NUMBER, "saturation", "largest output K of a cell, in the potential's unit; absent: none",
        SS_ABOVE(0, 1e30), .fallback = SS_ABSENT),
    [SS_CNN_SOURCE] = SS_PARAM(
        CHOICE, "source",
        "where energy enters: on every cell under a tool or of a load, or on the one contact cell",
        .range.max = 1.0, .choices = "footprint|contact"),
    [SS_CNN_SOLVER] = SS_PARAM(CHOICE, "solver",
                               "the network settled, or in its own time from the first touch on",
                               .range.max = 1.0, .choices = "equilibrium|relaxation"),
    [SS_CNN_RELAXATION_STEPS] =
        SS_PARAM(INTEGER, "relaxation_steps",
                 "steps of the network's own time a sub-step, with solver: relaxation",
                 SS_FROM(1.0, 10000.0), .fallback = 10.0),
    [SS_CNN_WINDOW_TOLERANCE] = /* the active set's; scenes have this name */
    SS_PARAM(NUMBER, "window_tolerance",
             "nodes of a large body that follow the far field within this share of the largest "
             "displacement take no step of their own; 0: all nodes do",
             SS_FROM(0, 0.01), .fallback = 8e-5),
};

/* ---- values a node ---- */

static double value_at(const ss_param_value *value, int32_t node)
{
    return value->per_node ? value->per_node[node] : value->number;
}

/* One field into `out`, times the node's size where that is wanted. Nodes that are no cells (size
 * below 0) get 0. */
static void fill_field(const ss_model_plan *plan, int row, const double *size, bool is_scaled,
                       double *out, softsim_error *error)
{
    const ss_param_row *spec = &ss_cnn_rows_table[row];
    ss_number_list bad = {0};
    for (int32_t i = 0; i < plan->mesh->node_count; ++i) {
        const double value = value_at(&plan->param[row], i);
        const bool is_good = isfinite(value) && ss_in_range(&spec->range, value);
        const bool is_used = size[i] >= 0.0;
        if (is_used && !is_good) {
            ss_number_list_add(&bad, ss_mesh_file_node(plan->mesh, i));
        }
        out[i] = !is_used ? 0.0 : is_scaled ? value * size[i] : value;
    }
    if (bad.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: %s must be %s 0 and at most %g at every node; %d nodes are "
                          "not (first %s)",
                          spec->name, spec->range.exclusive_min ? "greater than" : "at least",
                          spec->range.max, bad.count, bad.text);
    }
}

static void check_sizes(const ss_model_plan *plan, const double *size, bool is_volume,
                        bool is_scaled, softsim_error *error)
{
    ss_number_list loose = {0}, flat = {0};
    const bool has_inner = !is_volume && plan->mesh->tetrahedron_count > 0;
    for (int32_t i = 0; i < plan->mesh->node_count; ++i) {
        if (size[i] < 0.0 && !has_inner) {
            ss_number_list_add(&loose, ss_mesh_file_node(plan->mesh, i));
        }
        if (size[i] == 0.0 && is_scaled) {
            ss_number_list_add(&flat, ss_mesh_file_node(plan->mesh, i));
        }
    }
    if (loose.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "cnn-energy: %d nodes belong to no %s (first %s): remove them",
                          loose.count, is_volume ? "tetrahedron" : "triangle", loose.text);
    }
    if (flat.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "cnn-energy: %d nodes have only elements without %s (first %s), hence "
                          "no mass: repair the mesh or give masses with per_area: false",
                          flat.count, is_volume ? "volume" : "area", flat.text);
    }
}

/* Mass, damping and rest stiffness: by node, by area, by volume. */
enum { BY_NODE, BY_AREA, BY_VOLUME, KINDS };
static const int kind_row[KINDS][3] = {
    [BY_NODE] = {SS_CNN_MASS, SS_CNN_DAMPING, SS_CNN_REST_STIFFNESS},
    [BY_AREA] = {SS_CNN_AREA_DENSITY, SS_CNN_AREA_DAMPING, SS_CNN_AREA_REST_STIFFNESS},
    [BY_VOLUME] = {SS_CNN_VOLUME_DENSITY, SS_CNN_VOLUME_DAMPING, SS_CNN_VOLUME_REST_STIFFNESS}};

/* Exactly the three rows of the chosen kind must be given. */
static bool rows_are_given(const ss_model_plan *plan, int kind, softsim_error *error)
{
    const bool is_volume = plan->param[SS_CNN_DOMAIN].number != 0.0;
    bool is_good = true;
    for (int k = 0; k < 3 * KINDS; ++k) {
        const int other = k / 3, wanted = kind_row[kind][k % 3], row = kind_row[other][k % 3];
        const bool is_given = plan->param[row].is_given;
        if (other == kind && !is_given) {
            softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                              "cnn-energy: %s is missing (per_area is %s, domain %s)",
                              ss_cnn_rows_table[row].name, kind == BY_NODE ? "false" : "true",
                              is_volume ? "volume" : "surface");
        }
        if (other != kind && is_given) {
            const bool is_by_domain = other != BY_NODE && kind != BY_NODE;
            softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                              "cnn-energy: %s does not go with %s; give %s",
                              ss_cnn_rows_table[row].name,
                              is_by_domain      ? is_volume ? "domain: volume" : "domain: surface"
                              : kind == BY_NODE ? "per_area: false"
                                                : "per_area: true",
                              ss_cnn_rows_table[wanted].name);
        }
        is_good = is_good && is_given == (other == kind);
    }
    return is_good;
}

static void read_modulus(const ss_model_plan *plan, ss_cnn_material *material, softsim_error *error)
{
    const ss_param_value *param = plan->param;
    const bool is_volume = param[SS_CNN_DOMAIN].number != 0.0;
    const int row = is_volume ? SS_CNN_MODULUS_PA : SS_CNN_MODULUS_N_PER_M;
    const int other = is_volume ? SS_CNN_MODULUS_N_PER_M : SS_CNN_MODULUS_PA;
    const bool has_energy = param[SS_CNN_MODULUS_J].is_given;
    if (param[other].is_given) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: %s does not go with domain: %s; give modulus_j or %s",
                          ss_cnn_rows_table[other].name, is_volume ? "volume" : "surface",
                          ss_cnn_rows_table[row].name);
    }
    if (has_energy == param[row].is_given && (has_energy || !param[other].is_given)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE, "cnn-energy: give modulus_j or %s%s",
                          ss_cnn_rows_table[row].name, has_energy ? ", not both" : "");
    }
    const int chosen = has_energy ? SS_CNN_MODULUS_J : row;
    material->is_modulus_energy = has_energy;
    material->modulus = param[chosen].number;
    if (param[chosen].is_given &&
        !(material->modulus > 0.0 && material->modulus <= ss_cnn_rows_table[chosen].range.max)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: %s must be greater than 0 and at most %g",
                          ss_cnn_rows_table[chosen].name, ss_cnn_rows_table[chosen].range.max);
    }
}

/* Not given, or as --print-config prints what was not given. */
static bool is_default(const ss_model_plan *plan, int row)
{
    const ss_param_value *value = &plan->param[row];
    return !value->is_given ||
           (value->per_node == NULL && value->number == ss_cnn_rows_table[row].fallback);
}

static void read_numbers(const ss_model_plan *plan, ss_cnn_material *material, softsim_error *error)
{
    const ss_param_value *param = plan->param;
    read_modulus(plan, material, error);
    material->pretension = param[SS_CNN_PRETENSION_J].number;
    material->bulk = param[SS_CNN_ENCLOSED_BULK_PA].number;
    const ss_param_row *steps = &ss_cnn_rows_table[SS_CNN_RELAXATION_STEPS];
    if (!is_default(plan, SS_CNN_RELAXATION_STEPS) && param[SS_CNN_SOLVER].number == 0.0) {
        softsim_error_add(
            error, SOFTSIM_ERROR_SCENE,
            "cnn-energy: relaxation_steps goes with solver: relaxation; the solver is "
            "equilibrium");
    }
    if (!(param[SS_CNN_RELAXATION_STEPS].number >= steps->range.min &&
          param[SS_CNN_RELAXATION_STEPS].number <= steps->range.max)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: relaxation_steps must be %g to %g", steps->range.min,
                          steps->range.max);
    }
    const double k = param[SS_CNN_SATURATION].number;
    material->window_tolerance = param[SS_CNN_WINDOW_TOLERANCE].number;
    material->saturation = param[SS_CNN_SATURATION].is_given ? k : (double)INFINITY;
    if (!(material->pretension >= 0.0 && material->pretension <= 1e9) ||
        !(material->bulk >= 0.0 && material->bulk <= 1e12) || !(material->saturation > 0.0) ||
        !(material->window_tolerance >= 0.0 && material->window_tolerance <= 0.01)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: saturation must be greater than 0, pretension_j and "
                          "enclosed_bulk_pa at least 0, all of them finite, and window_tolerance 0 "
                          "to 0.01");
    }
}

/* What carries the cells; a volume that the mesh does not have is refused and its surface taken. */
static ss_cnn_element read_domain(const ss_model_plan *plan, softsim_error *error)
{
    const bool is_volume = plan->param[SS_CNN_DOMAIN].number != 0.0;
    if (is_volume && plan->mesh->tetrahedron_count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: domain: volume needs a mesh of tetrahedra, and this one is "
                          "a surface: make tetrahedra with softsim-mesh tetrahedralize, or take "
                          "domain: surface");
    }
    return is_volume && plan->mesh->tetrahedron_count > 0 ? SS_CNN_TETRAHEDRON
           : plan->mesh->quad_count > 0                   ? SS_CNN_QUAD
                                                          : SS_CNN_TRIANGLE;
}

/* ---- directions ---- */

static void check_directions(const ss_model_plan *plan, const ss_cnn_material *material,
                             softsim_error *error)
{
    const ss_param_value *value = &plan->param[SS_CNN_MATERIAL_DIRECTION];
    const ss_cnn_fabric fabric = {.mesh = plan->mesh, .element = material->element};
    if (value->per_element && plan->mesh->tetrahedron_count > 0 &&
        material->element != SS_CNN_TETRAHEDRON) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: material_direction by file is one a tetrahedron, which "
                          "domain: surface does not use: give one direction, or domain: volume");
        return;
    }
    const int32_t count = value->per_element ? ss_cnn_element_count(&fabric) : 1;
    ss_number_list bad = {0};
    for (int32_t e = 0; e < count; ++e) {
        const double *d = value->per_element ? value->per_element[e] : value->direction;
        if (!(fabs(ss_norm3(d) - 1.0) <= 1e-6)) {
            ss_number_list_add(&bad, ss_mesh_file_element(plan->mesh, e));
        }
    }
    if (bad.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: material_direction must have length 1; at %d elements it "
                          "has not (first %s)",
                          bad.count, bad.text);
    }
}

/* rho alone, or rho_direction and rho_across with what they need. Returns whether there are two. */
static bool read_anisotropy(const ss_model_plan *plan, const ss_cnn_material *material,
                            softsim_error *error)
{
    const ss_param_value *param = plan->param;
    const bool has_along = param[SS_CNN_RHO_DIRECTION].is_given;
    const bool has_across = param[SS_CNN_RHO_ACROSS].is_given;
    const bool has_direction = param[SS_CNN_MATERIAL_DIRECTION].is_given;
    if (!is_default(plan, SS_CNN_RHO) && (has_along || has_across)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: give rho, or rho_direction and rho_across, not both");
    }
    if (has_along != has_across) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: %s is missing: rho_direction and rho_across go together",
                          has_along ? "rho_across" : "rho_direction");
    }
    if (has_direction && !has_along && !has_across) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: material_direction needs rho_direction and rho_across; "
                          "without them the material has no direction: take it out");
    }
    if ((has_along || has_across) && !has_direction && material->element != SS_CNN_QUAD) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: rho_direction and rho_across need material_direction (only "
                          "a rectangular grid has directions of its own)");
    }
    if (has_direction) {
        check_directions(plan, material, error);
    }
    return has_along && has_across;
}

ss_cnn_fabric ss_cnn_material_fabric(const ss_model_plan *plan, const ss_cnn_material *material)
{
    const ss_param_value *value = &plan->param[SS_CNN_MATERIAL_DIRECTION];
    const bool has_direction = material->rho_across && value->is_given;
    return (ss_cnn_fabric){
        .mesh = plan->mesh,
        .element = material->element,
        .rho = material->rho,
        .rho_across = material->rho_across,
        .direction = has_direction && !value->per_element ? value->direction : NULL,
        .per_element = has_direction ? (const double(*)[3])value->per_element : NULL};
}

/* ---- life ---- */

/* Values a node, with `size` of every cell. */
static void fill_fields(const ss_model_plan *plan, ss_cnn_material *material, const double *size,
                        softsim_error *error)
{
    const bool is_volume = plan->param[SS_CNN_DOMAIN].number != 0.0;
    const bool is_scaled = plan->param[SS_CNN_PER_AREA].number != 0.0;
    const int kind = !is_scaled ? BY_NODE : is_volume ? BY_VOLUME : BY_AREA;
    check_sizes(plan, size, material->element == SS_CNN_TETRAHEDRON, is_scaled, error);
    fill_field(plan, material->rho_across ? SS_CNN_RHO_DIRECTION : SS_CNN_RHO, size, false,
               material->rho, error);
    if (material->rho_across) {
        fill_field(plan, SS_CNN_RHO_ACROSS, size, false, material->rho_across, error);
    }
    if (rows_are_given(plan, kind, error)) {
        const int *row = kind_row[kind];
        fill_field(plan, row[0], size, is_scaled, material->mass, error);
        fill_field(plan, row[1], size, is_scaled, material->damping, error);
        fill_field(plan, row[2], size, is_scaled, material->rest_stiffness, error);
    }
    for (int32_t i = 0; i < plan->mesh->node_count; ++i) {
        material->rho[i] = size[i] < 0.0 ? 1.0 : material->rho[i];
    }
}

softsim_status ss_cnn_material_create(const ss_model_plan *plan, ss_arena *arena,
                                      ss_cnn_material *out_material, softsim_error *error)
{
    const size_t n = (size_t)plan->mesh->node_count;
    const int32_t before = error ? error->fault_count : 0;
    ss_cnn_material material = {.element = read_domain(plan, error),
                                .mass = ss_arena_get(arena, n, sizeof(double)),
                                .damping = ss_arena_get(arena, n, sizeof(double)),
                                .rest_stiffness = ss_arena_get(arena, n, sizeof(double)),
                                .rho = ss_arena_get(arena, n, sizeof(double))};
    const bool is_anisotropic = read_anisotropy(plan, &material, error);
    material.rho_across = is_anisotropic ? ss_arena_get(arena, n, sizeof(double)) : NULL;
    double *size = ss_memory_get(n, sizeof *size);
    read_numbers(plan, &material, error);
    *out_material = material;
    if (ss_arena_status(arena) != SOFTSIM_OK || !size) {
        ss_memory_free(size);
        return SOFTSIM_ERROR_MEMORY;
    }
    const ss_cnn_fabric fabric = {.mesh = plan->mesh, .element = material.element};
    ss_cnn_cell_sizes(&fabric, size);
    fill_fields(plan, &material, size, error);
    ss_memory_free(size);
    return error && error->fault_count > before ? SOFTSIM_ERROR_SCENE : SOFTSIM_OK;
}

/* ---- the plan ---- */

softsim_status ss_cnn_plan_check(const ss_model_plan *plan, const ss_cnn_material *material,
                                 bool *out_is_held, softsim_error *error)
{
    static const char inside[] = "inside the volume, and domain: surface has no cells there: take "
                                 "them out, or domain: volume";
    const int32_t before = error ? error->fault_count : 0;
    const ss_cnn_fabric fabric = {.mesh = plan->mesh, .element = material->element};
    double *size = ss_memory_get((size_t)plan->mesh->node_count, sizeof *size);
    if (!size) {
        return SOFTSIM_ERROR_MEMORY;
    }
    ss_cnn_cell_sizes(&fabric, size);
    const softsim_status status =
        ss_plan_check(plan, "cnn-energy", size, plan->mesh->tetrahedron_count > 0 ? inside : NULL,
                      out_is_held, error);
    ss_memory_free(size);
    if (status == SOFTSIM_ERROR_MEMORY) {
        return status;
    }
    if (status == SOFTSIM_OK && !*out_is_held &&
        (material->pretension > 0.0 || material->bulk > 0.0)) {
        softsim_error_add(
            error, SOFTSIM_ERROR_SCENE,
            "cnn-energy: each separate part is to have three fixed nodes or more that "
            "are not in a line (object.fixed), since pretension_j and "
            "enclosed_bulk_pa pull on it; or set both to 0");
    }
    if (material->bulk > 0.0 && !plan->mesh->is_closed) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: enclosed_bulk_pa needs a closed surface");
    }
    return error && error->fault_count > before ? SOFTSIM_ERROR_SCENE : SOFTSIM_OK;
}
