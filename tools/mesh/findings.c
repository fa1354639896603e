/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "findings.h"

#include "command.h"

#include "rt/plain.h"
#include "rt/progress.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- findings ---- */

#define EVEN_AND_FILL                                                                              \
    "and fill it again: softsim-mesh convert IN surface.obj; softsim-mesh remesh surface.obj "     \
    "even.obj --edge-mm N; softsim-mesh tetrahedralize"
#define EVENED_OUT "softsim-mesh remesh IN OUT --edge-mm N evens them out"

/* The triangles of a surface decide the step of a network on it, and the tetrahedra beside it when
 * it is filled. What remesh refuses comes first: what crosses, and what is to be mended. */
static const char *sliver_remedy(const findings *f)
{
    const ss_mesh *m = f->mesh;
    const bool is_crossing = f->crossing.count > 0;
    bool is_refused = false;
    for (int32_t i = 0; i < f->row_count; ++i) {
        is_refused = is_refused || !f->row[i].is_harmless;
    }
    if (m->tetrahedron_count > 0) {
        return is_crossing ? "once nothing of its surface crosses, even that out, " EVEN_AND_FILL
                           : "even its surface out, " EVEN_AND_FILL;
    }
    return m->quad_count > 0 ? "give a more even grid"
           : is_crossing ? "the stable step follows the worst: once nothing crosses, " EVENED_OUT
           : is_refused  ? "the stable step follows the worst: once it is mended (softsim-mesh "
                           "convert --repair), " EVENED_OUT
                         : "the stable step follows the worst: " EVENED_OUT;
}

/* Those that ss_mesh_check has no row for; but for its size they leave a mesh usable, or mendable.
 */
static void add_own_rows(findings *f)
{
    const ss_mesh *m = f->mesh;
    f->inside_out.count = f->report.is_inside_out;
    f->part.count = f->report.component_count > 1 ? f->report.component_count : 0;
    f->joined.count = m->joined_node_count;
    f->unused.count = m->unused_node_count;
    /* Points, lines, and faces beside tetrahedra, only name nodes for groups. */
    const int first_body = m->tetrahedron_count > 0 ? SS_MESH_HIGHER_ORDER : SS_MESH_POLYGON;
    for (int kind = first_body; kind < SS_MESH_KIND_COUNT; ++kind) {
        f->skipped.count += m->skipped[kind];
    }
    f->size.count = !is_usable_size(&f->report, f->is_metric);
    const char *size_remedy = f->is_metric ? "give other --units, or scale it"
                                           : "scale it: it has that in no unit from mm to m";
    const char *sliver = m->tetrahedron_count > 0
                             ? "slivers (a dihedral angle outside 10 to 170 degrees, or 20 times "
                               "as long as high)"
                             : "slivers (an angle below 10 degrees)";
    const char *sliver_where = m->tetrahedron_count > 0 ? "tetrahedron"
                               : m->quad_count > 0      ? "quad"
                                                        : "triangle";
    const ss_mesh_finding own[] = {
        {"inside_out", &f->inside_out, "the surface is wound inside out", "", "flip it", false,
         true},
        {"size", &f->size, "a size that no scene takes (1e-7 to 1e5 m across)", "", size_remedy,
         false, false},
        {"hole", &f->hole, "holes", "at node", "close them if the body has a volume", true, true},
        {"component", &f->part, "separate parts", "", "forces do not pass between them", true,
         true},
        {"self_intersection", &f->crossing, "triangles that cross others", "triangle",
         "move them apart in the program that made it (a boolean union, or a remesh by voxels)",
         true, true},
        {"sliver", &f->quality.sliver, sliver, sliver_where, sliver_remedy(f), true, true},
        {"joined_node", &f->joined, "vertices on top of others, joined as the file was read", "",
         "merge vertices by distance", true, true},
        {"unused_node", &f->unused, "vertices without a face, left out as the file was read", "",
         "remove them", true, true},
        {"skipped_element", &f->skipped, "elements of kinds that no model has, left out", "",
         "divide them into tetrahedra, or triangles", true, true},
    };
    _Static_assert(sizeof own / sizeof *own == FINDINGS_OWN, "room for every row");
    for (int i = 0; i < FINDINGS_OWN; ++i) {
        if (own[i].fault->count > 0) {
            f->row[f->row_count++] = own[i];
        }
    }
}

/* As softsim-mesh scene and object.repair do; its size has a row of its own. */
static bool try_repair(const char *path, const ss_mesh *mesh)
{
    ss_mesh *mended = NULL;
    ss_mesh_repairs done;
    ss_progress_stage("trying to mend it");
    const bool is_good = ss_mesh_repair(mesh, &mended, &done, NULL) == SOFTSIM_OK &&
                         ss_mesh_accept_shape(mended, path, NULL) == SOFTSIM_OK;
    ss_mesh_destroy(&mended);
    return is_good;
}

bool findings_measure(findings *f, const char *path, const ss_mesh *mesh, bool is_metric,
                      bool is_check)
{
    *f = (findings){.path = path,
                    .is_metric = is_metric,
                    .mesh = mesh,
                    .is_check = is_check,
                    .is_crossing_complete = true};
    if (ss_mesh_check(mesh, &f->report) != SOFTSIM_OK) {
        return false;
    }
    ss_mesh_measure_quality(mesh, &f->quality);
    if (!is_check) {
        return true;
    }
    ss_progress_stage("looking for triangles that cross others, of %d", mesh->triangle_count);
    if (!ss_mesh_find_holes(mesh, &f->hole) ||
        !ss_mesh_find_crossings(mesh, &f->crossing, &f->is_crossing_complete)) {
        return false;
    }
    f->row_count = ss_mesh_list_findings(mesh, &f->report, f->row);
    add_own_rows(f);
    for (int32_t i = 0; i < f->row_count; ++i) {
        const int status = f->row[i].is_minor ? 1 : 2;
        f->status = status > f->status ? status : f->status;
        f->is_refused = f->is_refused || !f->row[i].is_harmless;
    }
    if (!f->is_crossing_complete && f->status == 0) {
        f->status = 1;
    }
    if (f->is_refused) {
        f->is_mended = f->size.count == 0 && try_repair(path, mesh);
        f->status = f->is_mended ? f->status : 2;
    }
    return true;
}

/* ---- text ---- */

static void print_histogram(const findings *f)
{
    (void)printf("angles      ");
    for (int bin = 0; bin < SS_MESH_ANGLE_BINS; ++bin) {
        if (f->quality.histogram[bin] > 0) {
            (void)printf("%d-%d: %lld  ", 10 * bin, 10 * bin + 10,
                         (long long)f->quality.histogram[bin]);
        }
    }
    (void)printf("(%s by their least %s, degrees)\n",
                 f->mesh->tetrahedron_count > 0 ? "tetrahedra"
                 : f->mesh->quad_count > 0      ? "quads"
                                                : "triangles",
                 f->mesh->tetrahedron_count > 0 ? "dihedral angle" : "angle");
}

static void print_measures(const findings *f)
{
    const ss_mesh *m = f->mesh;
    const ss_mesh_report *r = &f->report;
    (void)printf("nodes       %d\ntriangles   %d\ntetrahedra  %d\nparts       %d\n", m->node_count,
                 m->triangle_count, m->tetrahedron_count, r->component_count);
    if (m->quad_count > 0) {
        (void)printf("quads       %d (the triangles are their halves)\n", m->quad_count);
        (void)printf("directions  %lld edges where u of one quad meets w of the other\n",
                     (long long)r->mixed_direction.count);
    }
    if (m->middle != NULL) {
        (void)printf("order       2 (a node on every edge; the triangles are quarters of faces)\n");
    }
    if (m->cut_face_count > 0) {
        (void)printf("cut_faces   %d of more than three corners, since not all are quads\n",
                     m->cut_face_count);
    }
    for (int kind = 0; kind < SS_MESH_KIND_COUNT; ++kind) {
        if (m->split[kind] > 0) {
            (void)printf("split       %lld %s, into tetrahedra\n", (long long)m->split[kind],
                         ss_mesh_kind_name((ss_mesh_kind)kind));
        }
        if (m->skipped[kind] > 0) {
            (void)printf("left_out    %lld %s\n", (long long)m->skipped[kind],
                         ss_mesh_kind_name((ss_mesh_kind)kind));
        }
    }
    if (!f->is_check) {
        (void)printf("loading     %.3g s, %.4g MB kept, %.4g MB at most\n", f->loading_s,
                     1e-6 * (double)f->bytes_kept, 1e-6 * (double)f->bytes_at_most);
    }
    (void)printf("surface     %s\n", m->is_closed ? "closed" : "open");
    (void)printf("unit        %s\n", f->is_metric  ? "m"
                                     : f->is_check ? "the file's own (--units gives metres; the "
                                                     "models' figures take it as mm)"
                                                   : "the file's own (--units gives metres)");
    (void)printf("box         %g %g %g to %g %g %g\n", r->box_min[0], r->box_min[1], r->box_min[2],
                 r->box_max[0], r->box_max[1], r->box_max[2]);
    (void)printf("area        %g\n", r->area);
    if (m->is_closed) {
        (void)printf("volume      %g\n", r->volume);
    }
    (void)printf("edge        %g least, %g mean, %g greatest\n", r->edge_min, r->edge_mean,
                 r->edge_max);
    (void)printf("angle_deg   %.3g least\n", r->angle_min);
    if (m->tetrahedron_count > 0) {
        (void)printf("dihedral    %.3g least, %.4g greatest, degrees\n", f->quality.dihedral_min,
                     f->quality.dihedral_max);
    }
    print_histogram(f);
    for (int32_t g = 0; g < m->group_count; ++g) {
        (void)printf("group       %s: %d nodes\n", m->group[g].name, m->group[g].node_count);
    }
}

static void print_costs(const findings *f)
{
    if (f->cost_count > 0) {
        (void)printf("material    %s%s\n", cost_material,
                     f->is_metric ? "" : "; a length of 1 in the file taken as 1 mm");
    }
    for (int32_t i = 0; i < f->cost_count; ++i) {
        const model_cost *cost = &f->cost[i];
        if (cost->is_known && isinf(cost->stable_step_s)) {
            (void)printf("model       %s: stable at any step, %.3g MB\n", cost->name,
                         1e-6 * (double)cost->bytes);
        } else if (cost->is_known) {
            (void)printf("model       %s: stable step %.3g s, %.3g MB\n", cost->name,
                         cost->stable_step_s, 1e-6 * (double)cost->bytes);
        } else {
            (void)printf("model       %s: %s\n", cost->name, cost->reason);
        }
    }
}

static void print_row(const findings *f, const ss_mesh_finding *row)
{
    char numbers[160];
    if (row->where[0] != '\0') {
        ss_mesh_print_fault(row, numbers, sizeof numbers);
    } else {
        (void)snprintf(numbers, sizeof numbers, "%lld", (long long)row->fault->count);
    }
    const bool is_counted = row->fault != &f->inside_out && row->fault != &f->size;
    (void)fprintf(row->is_minor ? stdout : stderr, "%s%s: %s%s%s: %s\n",
                  row->is_minor ? "warning: " : "softsim-mesh: ", f->path, row->what,
                  is_counted ? ": " : "", is_counted ? numbers : "", row->remedy);
}

void findings_print(const findings *f)
{
    print_measures(f);
    if (!f->is_check) {
        return;
    }
    print_costs(f);
    (void)fflush(stdout);
    for (int32_t i = 0; i < f->row_count; ++i) {
        print_row(f, &f->row[i]);
    }
    if (!f->is_crossing_complete) {
        ss_plain_print(
            stdout,
            "warning: %s: too many triangles lie about each other to look at every pair: "
            "there may be more that cross\n",
            f->path);
    }
    static const char *const verdict[] = {"good", "usable with warnings", "unusable"};
    ss_plain_print(stdout, "%s: %s%s%s\n", f->path, verdict[f->status],
                   !f->is_refused   ? ""
                   : f->status == 1 ? " once mended: a scene refuses it as it is"
                                    : " as it is",
                   !f->is_refused ? ""
                   : f->is_mended
                       ? "; next: softsim-mesh scene mends it by itself, a scene by object.repair, "
                         "and softsim-mesh convert --repair IN OUT into a file"
                       : ", and no repair makes it usable; next: mend what is named above in the "
                         "program that made it");
}

/* ---- JSON ---- */

static void print_number(const char *name, double value)
{
    if (isfinite(value)) {
        (void)printf(", \"%s\": %.9g", name, value);
    } else {
        (void)printf(", \"%s\": null", name);
    }
}

static void print_corner(const char *name, const double x[3])
{
    (void)printf(", \"%s\": [%.9g, %.9g, %.9g]", name, x[0], x[1], x[2]);
}

static void print_json_measures(const findings *f)
{
    const ss_mesh *m = f->mesh;
    const ss_mesh_report *r = &f->report;
    (void)printf("\"nodes\": %d, \"triangles\": %d, \"quads\": %d, \"tetrahedra\": %d, "
                 "\"order\": %d, \"parts\": %d, \"is_closed\": %s, \"unit\": \"%s\"",
                 m->node_count, m->triangle_count, m->quad_count, m->tetrahedron_count,
                 m->middle != NULL ? 2 : 1, r->component_count, m->is_closed ? "true" : "false",
                 f->is_metric ? "m" : "file");
    print_corner("box_min", r->box_min);
    print_corner("box_max", r->box_max);
    print_number("area", r->area);
    print_number("volume", m->is_closed ? r->volume : (double)NAN);
    print_number("edge_min", r->edge_min);
    print_number("edge_mean", r->edge_mean);
    print_number("edge_max", r->edge_max);
    print_number("angle_min_deg", r->angle_min);
    const bool has_tetrahedra = m->tetrahedron_count > 0;
    print_number("dihedral_min_deg", has_tetrahedra ? f->quality.dihedral_min : (double)NAN);
    print_number("dihedral_max_deg", has_tetrahedra ? f->quality.dihedral_max : (double)NAN);
    (void)printf(", \"histogram_10_deg\": [");
    for (int bin = 0; bin < SS_MESH_ANGLE_BINS; ++bin) {
        (void)printf("%s%lld", bin > 0 ? ", " : "", (long long)f->quality.histogram[bin]);
    }
    (void)printf("], \"groups\": {");
    for (int32_t g = 0; g < m->group_count; ++g) {
        (void)printf("%s", g > 0 ? ", " : "");
        ss_plain_json(stdout, m->group[g].name);
        (void)printf(": %d", m->group[g].node_count);
    }
    (void)printf("}");
}

static void print_json_rows(const findings *f)
{
    (void)printf(", \"findings\": [");
    for (int32_t i = 0; i < f->row_count; ++i) {
        const ss_mesh_finding *row = &f->row[i];
        (void)printf("%s{\"key\": \"%s\", \"count\": %lld, \"status\": %d, \"is_refused\": %s, "
                     "\"first\": [",
                     i > 0 ? ", " : "", row->key, (long long)row->fault->count,
                     row->is_minor ? 1 : 2, row->is_harmless ? "false" : "true");
        const bool has_numbers = row->where[0] != '\0';
        for (int k = 0; k < SS_MESH_FIRST && k < row->fault->count && has_numbers; ++k) {
            (void)printf("%s%d", k > 0 ? ", " : "", row->fault->first[k]);
        }
        (void)printf("], \"what\": ");
        ss_plain_json(stdout, row->what);
        (void)printf("}");
    }
    (void)printf("], \"models\": [");
    for (int32_t i = 0; i < f->cost_count; ++i) {
        const model_cost *cost = &f->cost[i];
        (void)printf("%s{\"name\": \"%s\"", i > 0 ? ", " : "", cost->name);
        if (cost->is_known) {
            print_number("stable_step_s", cost->stable_step_s);
            (void)printf(", \"bytes\": %lld}", (long long)cost->bytes);
        } else {
            (void)printf(", \"reason\": ");
            ss_plain_json(stdout, cost->reason);
            (void)printf("}");
        }
    }
    (void)printf("]");
}

void findings_print_json(const findings *f)
{
    (void)printf("{\"file\": ");
    ss_plain_json(stdout, f->path);
    (void)printf(", ");
    if (f->is_check) {
        (void)printf("\"status\": %d, ", f->status);
    }
    print_json_measures(f);
    if (f->is_check) {
        (void)printf(", \"is_crossing_complete\": %s", f->is_crossing_complete ? "true" : "false");
        (void)printf(", \"is_mended_by_repair\": %s", f->is_mended ? "true" : "false");
        print_json_rows(f);
        (void)printf(", \"material\": ");
        ss_plain_json(stdout, cost_material);
        (void)printf(", \"models_unit\": \"%s\"", f->is_metric ? "m" : "mm");
    } else {
        print_number("loading_s", f->loading_s);
        print_number("bytes_kept", (double)f->bytes_kept);
        print_number("bytes_at_most", (double)f->bytes_at_most);
    }
    (void)printf("}\n");
}

void findings_print_json_error(const char *path, const softsim_error *error)
{
    (void)printf("{\"file\": ");
    ss_plain_json(stdout, path);
    (void)printf(", \"status\": 2, \"error\": ");
    ss_plain_json(stdout, error->text);
    (void)printf("}\n");
}
