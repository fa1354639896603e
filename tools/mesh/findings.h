/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What softsim-mesh info and check say of a file, as text and as JSON. Lengths are those of the
 * file, or metres where its unit was given.
 */
#include "cost.h"
#include "mesh/mesh.h"

enum { FINDINGS_OWN = 9 }; /* rows beside those of ss_mesh_check */

typedef struct findings {
    const char *path;
    bool is_metric; /* the file's unit was given */
    const ss_mesh *mesh;
    ss_mesh_report report;
    ss_mesh_quality quality;
    /* Of info alone. */
    double loading_s;
    int64_t bytes_kept, bytes_at_most; /* of the mesh, and while it was read (the importer's not) */
    /* Of check alone. */
    bool is_check;
    ss_mesh_fault hole, crossing, part, inside_out, size, joined, unused, skipped;
    bool is_crossing_complete;
    ss_mesh_finding row[SS_MESH_MAX_FINDINGS + FINDINGS_OWN];
    int32_t row_count;
    model_cost cost[COST_MAX_MODELS];
    int32_t cost_count;
    int status;      /* 0 good, 1 usable with warnings, 2 unusable */
    bool is_refused; /* by scenes, as it is */
    bool is_mended;  /* where it is refused: a repair makes it one that a scene takes */
} findings;

/* False when out of memory. */
bool findings_measure(findings *f, const char *path, const ss_mesh *mesh, bool is_metric,
                      bool is_check);
/* Faults go to stderr, all else to stdout. */
void findings_print(const findings *f);
void findings_print_json(const findings *f);
/* Of a file that cannot be read. */
void findings_print_json_error(const char *path, const softsim_error *error);
