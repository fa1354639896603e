/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A reference problem: a folder with a case.yaml that states material, supports, load levels and
 * files, and with a trusted solution on each of its meshes.
 *
 * In: the folder (a stranger's: sizes and numbers are checked, every fault is named with its file
 * and line). Files may be gzipped, whatever their names end in. Out: the statement, and for a mesh
 * its body: nodes in our order with the weights of the error norms, supports, prescribed nodes and
 * the reference displacements at every level.
 *
 * A body for a surface model is the surface file of a mesh: the numbers after its vertices
 * ("# node k", else the vertices count from 1) are those of the sets and of the reference; its
 * weights are its own nodal areas. Where a case has meshes of its own for surface models
 * (`surface_meshes`) those are taken in place of the others. Thread: one at a time.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "mesh/mesh.h"
#include "rt/files.h"
#include "softsim/types.h"

enum {
    SS_CASE_MAX_LEVELS = 64,
    SS_CASE_MAX_MESHES = 32,
    SS_CASE_MAX_MATERIALS = 8,
    SS_CASE_MAX_STEPS = 8,
    SS_CASE_PATH = 512
};

typedef struct ss_case_level {
    int32_t material; /* index into ss_case.material */
    char tag[32];     /* of the reference's columns */
    double value;     /* m of push, Pa, or a factor of gravity */
    double force;     /* of the tool on the tissue along the push, N; NaN: not known */
} ss_case_level;

/* File names relative to ss_case.mesh_folder; "" where there is none. */
typedef struct ss_case_mesh {
    char name[32];
    char volume[SS_CASE_PATH], surface[SS_CASE_PATH], sets[SS_CASE_PATH];
    char reference[SS_CASE_MAX_MATERIALS][SS_CASE_PATH];
} ss_case_mesh;

/* A step of gravity from rest, undamped: what the point ss_case.probe does. */
typedef struct ss_case_step {
    double gravity[3];
    double until; /* s: compared so far; at most 1000 */
    int32_t count;
    double *time, (*u)[3]; /* s, m */
} ss_case_step;

typedef struct ss_case {
    char folder[SS_CASE_PATH], mesh_folder[SS_CASE_PATH];
    char forces[SS_CASE_PATH]; /* the table of them in `folder`; "" where there is none */
    char name[64];
    bool is_dynamic;
    double youngs_modulus, poisson_ratio, density; /* SI; density NaN: not given */
    char material[SS_CASE_MAX_MATERIALS][32];
    int32_t material_count;
    char fixed[32]; /* names of node sets; "" where there is none */
    char pushed[32], profile[32], pressed[32];
    double direction[3]; /* of the push, a unit vector; u = level x profile x direction */
    double gravity[3];   /* m/s^2, times the level */
    ss_case_level level[SS_CASE_MAX_LEVELS]; /* by material, then as the file has them */
    int32_t level_count;
    ss_case_mesh mesh[SS_CASE_MAX_MESHES], surface_mesh[SS_CASE_MAX_MESHES];
    int32_t mesh_count, surface_mesh_count;
    /* dynamic */
    double probe[3];        /* m */
    double first_frequency; /* Hz; NaN: not known */
    ss_case_step step[SS_CASE_MAX_STEPS];
    int32_t step_count;
} ss_case;

/* Every fault is in `error`. ss_case_fini afterwards, also on failure. */
softsim_status ss_case_load(const char *folder, ss_case *out, softsim_error *error);
void ss_case_fini(ss_case *c);

/* The path of a file that a case names: relative names are of `folder`. */
void ss_case_join(const char *folder, const char *name, char *out, size_t size);

/* Adds a fault for the first output that is a file of a static case, whichever mesh and material
 * are asked for (ss_files_check); true without one. */
bool ss_case_check_outputs(const ss_case *c, const ss_named_file *output, int32_t output_count,
                           softsim_error *error);

/* The meshes that a model runs on. */
const ss_case_mesh *ss_case_meshes(const ss_case *c, bool on_surface, int32_t *out_count);
/* Has the mesh a file of that kind? */
bool ss_case_has_body(const ss_case_mesh *mesh, bool on_surface);

typedef struct ss_case_body {
    ss_mesh *mesh;    /* m, nodes in the file's order (of a surface: without unused vertices) */
    int32_t *number;  /* the file's number of each node */
    double *weight;   /* m^3 or m^2: of the norms; volumes come with the reference */
    int32_t *fixed;   /* nodes; fixed_count */
    int32_t *pushed;  /* pushed_count */
    double *profile;  /* of the pushed nodes */
    int32_t *pressed; /* pressed_count */
    int32_t fixed_count, pushed_count, pressed_count;
    int32_t level_count;
    double (**reference)[3]; /* m, by level of the case; NULL for those of other materials */
} ss_case_body;

/* Reads what the mesh needs for `material` (an index; -1: no reference). Faults are in `error`.
 * ss_case_body_fini afterwards, also on failure. */
softsim_status ss_case_load_body(const ss_case *c, const ss_case_mesh *mesh, int32_t material,
                                 bool on_surface, ss_case_body *out, softsim_error *error);
void ss_case_body_fini(ss_case_body *body);
