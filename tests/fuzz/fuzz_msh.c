/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * libFuzzer over the MSH reader. What it accepts must have indices in range and finite positions,
 * groups with nodes in increasing order, and must survive every check and measure. A text that
 * does not start with '$' is put behind the format line, which the fuzzer would hardly find.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(bool holds)
{
    if (!holds) {
        abort();
    }
}

static void examine(ss_mesh *mesh)
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
    for (int32_t g = 0; g < mesh->group_count; ++g) {
        const ss_mesh_group *group = &mesh->group[g];
        require(group->node_count > 0 && memchr(group->name, '\0', sizeof group->name) != NULL);
        for (int32_t i = 0; i < group->node_count; ++i) {
            require(group->node[i] >= 0 && group->node[i] < mesh->node_count);
            require(i == 0 || group->node[i] > group->node[i - 1]);
        }
    }
    const bool is_usable = ss_mesh_accept(mesh, "fuzz", &error) == SOFTSIM_OK;
    require(ss_mesh_orient(mesh) >= 0);
    require(ss_mesh_orient(mesh) == 0 || report.non_manifold_edge.count > 0 ||
            report.inconsistent_winding.count > 0 || report.zero_area.count > 0 ||
            !isfinite(report.volume));
    if (is_usable) {
        require(ss_mesh_renumber(mesh));
        require(ss_mesh_accept(mesh, "renumbered", &error) == SOFTSIM_OK);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char head[] = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n";
    const size_t extra = size > 0 && data[0] != '$' ? sizeof head - 1 : 0;
    char *text = malloc(size + extra + 1);
    require(text != NULL);
    memcpy(text, head, extra);
    if (size > 0) {
        memcpy(text + extra, data, size);
    }
    /* An exact copy, so that one byte too many is seen. */
    char *exact = realloc(text, size + extra > 0 ? size + extra : 1);
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    require(exact != NULL);
    const softsim_status status =
        ss_mesh_read_msh(exact, size + extra, "fuzz", 0.001, &mesh, &error);
    require((status == SOFTSIM_OK) == (mesh != NULL) &&
            (status == SOFTSIM_OK) == (error.fault_count == 0));
    if (mesh != NULL) {
        examine(mesh);
    }
    ss_mesh_destroy(&mesh);
    free(exact);
    return 0;
}
