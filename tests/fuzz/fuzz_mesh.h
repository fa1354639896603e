/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What every mesh reader's fuzzer asks of what was read: indices in range, finite positions, groups
 * with nodes in increasing order; and it must survive every check, measure and change.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "mesh/mesh.h"
#include "mesh/readers.h"
#include "rt/memory.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(bool holds)
{
    if (!holds) {
        abort();
    }
}

static void examine_groups(const ss_mesh *mesh)
{
    for (int32_t g = 0; g < mesh->group_count; ++g) {
        const ss_mesh_group *group = &mesh->group[g];
        require(group->node_count > 0 && memchr(group->name, '\0', sizeof group->name) != NULL);
        for (int32_t i = 0; i < group->node_count; ++i) {
            require(group->node[i] >= 0 && group->node[i] < mesh->node_count);
            require(i == 0 || group->node[i] > group->node[i - 1]);
        }
    }
}

/* Of the other order, mended; a good mesh stays one. */
static void examine_changes(const ss_mesh *mesh, bool is_usable)
{
    softsim_error error = {0};
    ss_mesh_repairs done;
    ss_mesh *changed = NULL;
    const softsim_status status =
        (mesh->middle != NULL ? ss_mesh_lower : ss_mesh_raise)(mesh, &changed, &error);
    require((status == SOFTSIM_OK) == (changed != NULL));
    require(changed == NULL || (changed->middle == NULL) == (mesh->middle != NULL));
    require(changed != NULL || !is_usable || mesh->tetrahedron_count == 0);
    if (is_usable && mesh->middle == NULL && changed != NULL) {
        /* Where faces do not conform, two diagonals of a square may have their middle in common. */
        ss_mesh_report report;
        require(ss_mesh_check(changed, &report) == SOFTSIM_OK);
        require(ss_mesh_accept(changed, "raised", &error) == SOFTSIM_OK ||
                report.coincident_node.count > 0);
    }
    ss_mesh_destroy(&changed);
    require((ss_mesh_repair(mesh, &changed, &done, &error) == SOFTSIM_OK) == (changed != NULL));
    ss_mesh_destroy(&changed);
}

static void examine_mesh(ss_mesh *mesh)
{
    ss_mesh_report report;
    softsim_error error = {0};
    double *area = malloc((size_t)mesh->node_count * sizeof *area);
    require(area != NULL);
    ss_mesh_node_areas(mesh, area);
    free(area);
    require(ss_mesh_check(mesh, &report) == SOFTSIM_OK);
    require(report.non_finite.count == 0 && report.bad_index.count == 0);
    require(mesh->quad_count == 0 || mesh->triangle_count == 2 * mesh->quad_count);
    require(mesh->quad_count == 0 || (mesh->tetrahedron_count == 0 && mesh->cut_face_count == 0));
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            require(mesh->triangle[t][k] >= 0 && mesh->triangle[t][k] < mesh->node_count);
        }
    }
    require(mesh->middle == NULL || mesh->triangle_count % 4 == 0);
    for (int64_t s = 0; mesh->middle != NULL && s < 6 * (int64_t)mesh->tetrahedron_count; ++s) {
        const int32_t node = mesh->middle[s / 6][s % 6];
        require(node >= 0 && node < mesh->node_count);
    }
    for (int kind = 0; kind < SS_MESH_KIND_COUNT; ++kind) {
        require(mesh->skipped[kind] >= 0);
    }
    examine_groups(mesh);
    const bool is_usable = ss_mesh_accept(mesh, "fuzz", &error) == SOFTSIM_OK;
    examine_changes(mesh, is_usable);
    require(ss_mesh_orient(mesh) >= 0);
    require(ss_mesh_orient(mesh) == 0 || report.non_manifold_edge.count > 0 ||
            report.pinched_edge.count > 0 || report.pinched_node.count > 0 ||
            report.inconsistent_winding.count > 0 || report.zero_area.count > 0 ||
            !isfinite(report.volume));
    if (is_usable) {
        require(ss_mesh_renumber(mesh));
        require(ss_mesh_accept(mesh, "renumbered", &error) == SOFTSIM_OK);
    }
}

/* A mesh or faults, never both; then examines and frees it. */
static void examine(softsim_status status, ss_mesh *mesh, const softsim_error *error)
{
    require((status == SOFTSIM_OK) == (mesh != NULL) &&
            (status == SOFTSIM_OK) == (error->fault_count == 0));
    if (mesh != NULL) {
        examine_mesh(mesh);
    }
    ss_mesh_destroy(&mesh);
    require(ss_memory_in_use() == 0);
}

typedef softsim_status parser(ss_text *text, double metres_per_unit, ss_mesh **out_mesh);

/* Reads a head and the data behind it, from memory and through a narrow window: what the window
 * shows must be the same, but for pieces that do not fit into it. */
static inline void fuzz_text(parser *parse, const char *head, size_t head_size, const uint8_t *data,
                             size_t size)
{
    ss_text text;
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    /* An exact copy, so that one byte too many is seen. */
    char *copy = malloc(head_size + size > 0 ? head_size + size : 1);
    require(copy != NULL);
    memcpy(copy, head, head_size);
    if (size > 0) {
        memcpy(copy + head_size, data, size);
    }
    ss_text_init(&text, copy, head_size + size, "fuzz", &error);
    const softsim_status status = parse(&text, 0.001, &mesh);
    const int32_t nodes = mesh != NULL ? mesh->node_count : 0;
    examine(status, mesh, &error);

    static int fd = -1;
    fd = fd >= 0 ? fd : memfd_create("fuzz", 0);
    require(fd >= 0 && ftruncate(fd, 0) == 0 &&
            pwrite(fd, copy, head_size + size, 0) == (ssize_t)(head_size + size));
    softsim_error again = {0};
    require(ss_text_open(&text, fd, (int64_t)(head_size + size), 128, "fuzz", &again));
    const softsim_status windowed = parse(&text, 0.001, &mesh);
    require(windowed == status || text.has_failed);
    require(mesh == NULL || mesh->node_count == nodes);
    ss_text_fini(&text);
    examine(windowed, mesh, &again);
    free(copy);
}
