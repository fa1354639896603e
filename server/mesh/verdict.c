/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What a report (check.c) means: the words for each kind of fault and of repair (repair.c), and
 * whether a scene takes a mesh.
 */
#include "mesh/mesh.h"
#include "rt/vec.h"

#include <stddef.h>
#include <stdio.h>

/* Rows of ss_mesh_list_findings; texts for quads where they differ. */
typedef struct finding_row {
    size_t field;
    const char *key, *what, *quad_what, *where, *remedy;
    bool is_harmless, is_minor;
} finding_row;

#define ROW(name) offsetof(ss_mesh_report, name), #name
static const finding_row rows[] = {
    {ROW(non_finite), "nodes that are not finite", NULL, "node",
     "correct or remove them (none may be beyond 1e60)", false, false},
    {ROW(bad_index), "elements of nodes that do not exist", NULL, "element",
     "the file is damaged: write it again", false, false},
    {ROW(zero_area), "flat triangles", "quads that are flat or half flat", NULL,
     "softsim-mesh convert --repair closes them up", false, false},
    {ROW(duplicate_triangle), "duplicate triangles", "duplicate quads", NULL,
     "softsim-mesh convert --repair drops them", false, false},
    {ROW(loose_node), "nodes without an element", NULL, "node", "remove them", false, true},
    {ROW(coincident_node), "nodes on top of others", NULL, "node", "merge vertices by distance",
     false, true},
    {ROW(short_edge), "edges shorter than 1/1000 of the mean", NULL, "at node",
     "softsim-mesh convert --repair closes them up", false, true},
    {ROW(non_manifold_edge), "edges of more than two triangles",
     "edges of more than two quads, or diagonals of more than one", "at node",
     "softsim-mesh convert --repair parts them into sheets, and drops inner walls", false, false},
    {ROW(non_manifold_node), "nodes where surfaces touch in a point only", NULL, "node",
     "softsim-mesh convert --repair parts them; or join them by more than a point", false, false},
    {ROW(inconsistent_winding), "edges whose two triangles are wound against each other",
     "edges whose two quads are wound against each other", "at node",
     "softsim-mesh convert --repair turns them", false, false},
    {ROW(duplicate_tetrahedron), "duplicate tetrahedra", NULL, "tetrahedron", "remove them", false,
     false},
    {ROW(crowded_face), "faces of more than two tetrahedra", NULL, "at node",
     "remove overlapping tetrahedra", false, false},
    {ROW(inverted_tetrahedron), "inverted tetrahedra", NULL, "tetrahedron",
     "swap two of their nodes if all are inverted, else remesh", false, false},
    {ROW(overlapping_tetrahedron), "tetrahedra that overlap their neighbours", NULL, "tetrahedron",
     "nodes were moved through others: fill its surface again, by softsim-mesh tetrahedralize",
     false, false},
    {ROW(flat_tetrahedron), "tetrahedra without a volume", NULL, "tetrahedron",
     "remove them, or remesh", false, false},
    {ROW(parted_side), "edges that two tetrahedra give different mid-edge nodes", NULL, "at node",
     "merge vertices by distance, or mesh it again", false, false},
    {ROW(shared_middle), "mid-edge nodes of more than one edge, or at a corner too", NULL, "node",
     "mesh it again, or take its corners alone (softsim-mesh convert --order 1)", false, false},
    {ROW(bent_tetrahedron), "tetrahedra that their mid-edge nodes turn inside out", NULL,
     "tetrahedron",
     "write the nodes in the format's own order, remesh, or take the corners alone (softsim-mesh "
     "convert --order 1)",
     false, false},
    {ROW(pinched_edge), "edges in which the body touches itself", NULL, "at node",
     "it runs as it is; join its parts by more than an edge if they should be one", true, true},
    {ROW(pinched_node), "nodes in which the body touches itself", NULL, "node",
     "it runs as it is; join its parts by more than a point if they should be one", true, true},
    {ROW(open_edge), "open edges", NULL, "at node",
     "the body has no volume; close the holes if it should", true, true},
};
_Static_assert(sizeof rows / sizeof rows[0] <= SS_MESH_MAX_FINDINGS, "room for every row");

int32_t ss_mesh_list_findings(const ss_mesh *mesh, const ss_mesh_report *report,
                              ss_mesh_finding out[SS_MESH_MAX_FINDINGS])
{
    const bool has_quads = mesh->quad_count > 0;
    int32_t count = 0;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        const finding_row *row = &rows[i];
        const ss_mesh_fault *fault = (const void *)((const char *)report + row->field);
        if (fault->count == 0) {
            continue;
        }
        ss_mesh_finding *f = &out[count++];
        *f = (ss_mesh_finding){.key = row->key,
                               .fault = fault,
                               .what =
                                   has_quads && row->quad_what != NULL ? row->quad_what : row->what,
                               .where = row->where,
                               .remedy = row->remedy,
                               .is_harmless = row->is_harmless,
                               .is_minor = row->is_minor};
        if (f->where == NULL) {
            f->where = has_quads ? "quad" : "triangle";
        }
        /* Some programs write every tetrahedron inverted; swapping two nodes of each repairs it. */
        f->is_minor = f->is_minor || (fault == &report->inverted_tetrahedron &&
                                      fault->count == mesh->tetrahedron_count);
    }
    return count;
}

int32_t ss_mesh_list_repairs(const ss_mesh_repairs *repairs, bool is_volume,
                             ss_mesh_finding out[SS_MESH_MAX_FINDINGS])
{
#define REPAIR(name) offsetof(ss_mesh_repairs, name), #name
    static const struct {
        size_t field;
        const char *key, *what, *where; /* NULL: of elements */
        bool keeps_numbers;
    } repair_rows[] = {
        {REPAIR(bad_element), "elements of bad nodes dropped", NULL, false},
        {REPAIR(cut_quad), "quads cut into triangles", "quad", false},
        {REPAIR(welded_node), "nodes welded to others", "node", false},
        {REPAIR(flat_element), "flat elements dropped", NULL, false},
        {REPAIR(twin_element), "duplicate elements dropped", NULL, false},
        {REPAIR(divided_triangle), "triangles divided at nodes on their edges", "triangle", false},
        {REPAIR(flap_triangle), "triangles of inner walls and flaps dropped", "triangle", false},
        {REPAIR(parted_edge), "edges of more than two triangles parted into sheets", "at node",
         false},
        {REPAIR(cut_edge), "edges of one-sided surfaces cut", "at node", false},
        {REPAIR(parted_node), "nodes parted where sheets touched", "node", false},
        {REPAIR(sliver_part), "parts dropped that enclose no volume or are too small", "triangle",
         false},
        {REPAIR(filled_hole), "holes filled", "at node", false},
        {REPAIR(loose_node), "loose nodes dropped", "node", false},
        {REPAIR(turned_tetrahedron), "tetrahedra turned", "tetrahedron", true},
        {REPAIR(turned_triangle), "triangles turned", NULL, true},
    };
#undef REPAIR
    _Static_assert(sizeof repair_rows / sizeof *repair_rows <= SS_MESH_MAX_FINDINGS,
                   "room for every row");
    int32_t count = 0;
    for (size_t i = 0; i < sizeof repair_rows / sizeof *repair_rows; ++i) {
        const ss_mesh_fault *fault = (const void *)((const char *)repairs + repair_rows[i].field);
        if (fault->count > 0) {
            out[count++] =
                (ss_mesh_finding){.key = repair_rows[i].key,
                                  .fault = fault,
                                  .what = repair_rows[i].what,
                                  .where = repair_rows[i].where != NULL ? repair_rows[i].where
                                           : is_volume                  ? "tetrahedron"
                                                                        : "face",
                                  .is_harmless = repair_rows[i].keeps_numbers};
        }
    }
    return count;
}

void ss_mesh_print_fault(const ss_mesh_finding *finding, char *out, size_t size)
{
    const ss_mesh_fault *fault = finding->fault;
    size_t used = (size_t)snprintf(out, size, "%lld (%s ", (long long)fault->count, finding->where);
    for (int i = 0; i < SS_MESH_FIRST && i < fault->count && used < size; ++i) {
        used +=
            (size_t)snprintf(out + used, size - used, "%s%d", i > 0 ? ", " : "", fault->first[i]);
    }
    if (used < size) {
        (void)snprintf(out + used, size - used, "%s)", fault->count > SS_MESH_FIRST ? ", ..." : "");
    }
}

bool ss_mesh_is_size_usable(double diagonal)
{
    return diagonal >= SS_MESH_LEAST_SIZE && diagonal <= SS_MESH_GREATEST_SIZE;
}

softsim_status ss_mesh_accept_shape(const ss_mesh *mesh, const char *name, softsim_error *error)
{
    ss_mesh_report r;
    if (ss_mesh_check(mesh, &r) != SOFTSIM_OK) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory while checking it", name);
        return SOFTSIM_ERROR_MEMORY;
    }
    ss_mesh_finding found[SS_MESH_MAX_FINDINGS];
    const int32_t count = ss_mesh_list_findings(mesh, &r, found);
    bool is_usable = true;
    for (int32_t i = 0; i < count; ++i) {
        char numbers[160];
        ss_mesh_print_fault(&found[i], numbers, sizeof numbers);
        if (!found[i].is_harmless) {
            is_usable = false;
            softsim_error_add(error, SOFTSIM_ERROR_MESH, "%s: %s: %s: %s", name, found[i].what,
                              numbers, found[i].remedy);
        }
    }
    if (r.is_inside_out) {
        is_usable = false;
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "%s: the surface is wound inside out: flip its normals", name);
    }
    return is_usable ? SOFTSIM_OK : SOFTSIM_ERROR_MESH;
}

softsim_status ss_mesh_accept(const ss_mesh *mesh, const char *name, softsim_error *error)
{
    const softsim_status status = ss_mesh_accept_shape(mesh, name, error);
    const double size = ss_mesh_diagonal(mesh);
    if (status == SOFTSIM_OK && !ss_mesh_is_size_usable(size)) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "%s: %g m across: check its units and scale (%g to %g m are usable)",
                          name, size, SS_MESH_LEAST_SIZE, SS_MESH_GREATEST_SIZE);
        return SOFTSIM_ERROR_MESH;
    }
    return status;
}
