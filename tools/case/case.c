/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * case.yaml, the table of forces, the steps of a dynamic case. The text is read by the scene's own
 * bounded YAML reader, so that faults have their line and a caret. Keys that are not known are
 * faults: a misspelt support would be a different problem.
 */
#include "case/case.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "case/table.h"
#include "rt/each.h"
#include "rt/vec.h"
#include "scene/report.h"
#include "scene/tree.h"

static const double longest_s = 1e3; /* of a motion: a million steps of 1 ms, all of them kept */

typedef struct reader {
    ss_scene_report *report;
    ss_case *out;
} reader;

/* ---- values ---- */

static bool get_number(reader *r, ss_scene_node *node, double min, double max, double *out)
{
    if (node->kind != SS_SCENE_SCALAR || node->is_quoted ||
        ss_scene_parse_number(node->text, out) != SS_SCENE_GOOD || *out < min || *out > max) {
        ss_scene_node_fault(r->report, node, "must be a number of %g to %g", min, max);
        return false;
    }
    return true;
}

static bool get_text(reader *r, ss_scene_node *node, char *out, size_t size)
{
    if (node->kind != SS_SCENE_SCALAR || *node->text == '\0' || strlen(node->text) >= size) {
        ss_scene_node_fault(r->report, node, "must be a text of at most %d characters",
                            (int)size - 1);
        return false;
    }
    snprintf(out, size, "%s", node->text);
    return true;
}

/* Names become those of files and of series in pictures. */
static bool is_plain(const char *name)
{
    return *name != '\0' && *name != '.' &&
           name[strspn(
               name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.+-")] == '\0';
}

static bool get_vector(reader *r, ss_scene_node *node, double out[3])
{
    if (node->kind != SS_SCENE_LIST || node->count != 3) {
        ss_scene_node_fault(r->report, node, "must be a list of three numbers");
        return false;
    }
    for (ss_scene_node *at = node->first; at != NULL; at = at->next) {
        if (!get_number(r, at, -1e6, 1e6, &out[at->index])) {
            return false;
        }
    }
    return true;
}

static ss_scene_node *need(reader *r, ss_scene_node *map, const char *key)
{
    ss_scene_node *node = ss_scene_node_find(map, key);
    if (node == NULL) {
        ss_scene_node_fault(r->report, map, "the key '%s' is missing", key);
    }
    return node;
}

/* Is `map` a mapping with none but these keys ("a|b|c")? */
static bool check_keys(reader *r, ss_scene_node *map, const char *keys)
{
    if (map->kind != SS_SCENE_MAP) {
        ss_scene_node_fault(r->report, map, "must be a mapping");
        return false;
    }
    bool is_good = true;
    for (ss_scene_node *node = map->first; node != NULL; node = node->next) {
        const size_t length = strlen(node->key);
        const char *at = keys;
        while (at != NULL &&
               (strncmp(at, node->key, length) != 0 || (at[length] != '|' && at[length] != '\0'))) {
            at = strchr(at, '|');
            at = at != NULL ? at + 1 : NULL;
        }
        if (at == NULL) {
            ss_scene_key_fault(r->report, node, "unknown key; known here: %s", keys);
            is_good = false;
        }
    }
    return is_good;
}

static void take_text(reader *r, ss_scene_node *map, const char *key, char *out, size_t size)
{
    ss_scene_node *node = ss_scene_node_find(map, key);
    if (node != NULL) {
        get_text(r, node, out, size);
    }
}

/* ---- material and loads ---- */

static void read_material(reader *r, ss_scene_node *root)
{
    ss_scene_node *map = need(r, root, "material");
    r->out->density = (double)NAN;
    if (map == NULL || !check_keys(r, map, "youngs_modulus_pa|poisson_ratio|density_kg_m3")) {
        return;
    }
    ss_scene_node *modulus = need(r, map, "youngs_modulus_pa");
    ss_scene_node *ratio = need(r, map, "poisson_ratio");
    ss_scene_node *density = ss_scene_node_find(map, "density_kg_m3");
    if (modulus != NULL) {
        get_number(r, modulus, 1e-3, 1e14, &r->out->youngs_modulus);
    }
    if (ratio != NULL) {
        get_number(r, ratio, -0.99, 0.499999, &r->out->poisson_ratio);
    }
    if (density != NULL) {
        get_number(r, density, 1e-6, 1e9, &r->out->density);
    }
}

static void read_push(reader *r, ss_scene_node *root)
{
    ss_case *c = r->out;
    ss_scene_node *map = ss_scene_node_find(root, "prescribed");
    if (map != NULL && check_keys(r, map, "set|direction|profile")) {
        ss_scene_node *set = need(r, map, "set");
        ss_scene_node *direction = need(r, map, "direction");
        if (set != NULL) {
            get_text(r, set, c->pushed, sizeof c->pushed);
        }
        take_text(r, map, "profile", c->profile, sizeof c->profile);
        if (direction != NULL && get_vector(r, direction, c->direction)) {
            const double length = ss_norm3(c->direction);
            if (fabs(length - 1.0) > 1e-3) {
                ss_scene_node_fault(r->report, direction,
                                    "must be a unit vector: its length is %.6g", length);
            }
        }
    }
    map = ss_scene_node_find(root, "pressure");
    if (map != NULL && check_keys(r, map, "set")) {
        ss_scene_node *set = need(r, map, "set");
        if (set != NULL) {
            get_text(r, set, c->pressed, sizeof c->pressed);
        }
    }
    map = ss_scene_node_find(root, "gravity_m_s2");
    if (map != NULL) {
        get_vector(r, map, c->gravity);
    }
    if (isnan(c->density) && (c->is_dynamic || ss_norm3(c->gravity) > 0.0)) {
        ss_scene_node_fault(r->report, root, "gravity needs material.density_kg_m3");
    }
    if (!c->is_dynamic && c->pushed[0] == '\0' && c->pressed[0] == '\0' &&
        ss_norm3(c->gravity) == 0.0) {
        ss_scene_node_fault(r->report, root,
                            "nothing loads the body: give prescribed, pressure or gravity_m_s2");
    }
}

static int32_t find_material(const ss_case *c, const char *name)
{
    int32_t m = 0;
    while (m < c->material_count && strcmp(c->material[m], name) != 0) {
        ++m;
    }
    return m < c->material_count ? m : -1;
}

static void read_level(reader *r, ss_scene_node *node, int32_t material)
{
    ss_case *c = r->out;
    double value = 0.0;
    if (!get_number(r, node, -1e12, 1e12, &value)) {
        return;
    }
    ss_case_level *level = &c->level[c->level_count];
    if (c->level_count == SS_CASE_MAX_LEVELS || strlen(node->key) >= sizeof level->tag ||
        value == 0.0) {
        ss_scene_key_fault(r->report, node,
                           value == 0.0 ? "a level of nothing has no error"
                                        : "more levels, or a longer name, than fit (%d, %d)",
                           SS_CASE_MAX_LEVELS, (int)sizeof level->tag - 1);
        return;
    }
    *level = (ss_case_level){.material = material, .value = value, .force = (double)NAN};
    snprintf(level->tag, sizeof level->tag, "%s", node->key);
    ++c->level_count;
}

static void read_levels(reader *r, ss_scene_node *root)
{
    ss_case *c = r->out;
    ss_scene_node *map = need(r, root, "levels");
    if (map == NULL || map->kind != SS_SCENE_MAP || map->count > SS_CASE_MAX_MATERIALS) {
        if (map != NULL) {
            ss_scene_node_fault(r->report, map, "must be a mapping of at most %d materials",
                                SS_CASE_MAX_MATERIALS);
        }
        return;
    }
    for (ss_scene_node *node = map->first; node != NULL; node = node->next) {
        const int32_t m = c->material_count;
        if (node->kind != SS_SCENE_MAP || strlen(node->key) >= sizeof c->material[m] ||
            !is_plain(node->key)) {
            ss_scene_node_fault(r->report, node,
                                "must be a mapping of levels, 'tag: value', under a plain name");
            continue;
        }
        snprintf(c->material[m], sizeof c->material[m], "%s", node->key);
        ++c->material_count;
        if (node->first == NULL) {
            ss_scene_node_fault(r->report, node, "no level is given");
        }
        for (ss_scene_node *level = node->first; level != NULL; level = level->next) {
            read_level(r, level, m);
        }
    }
    if (c->level_count == 0) {
        ss_scene_node_fault(r->report, map, "no level is given");
    }
}

/* ---- meshes ---- */

static void read_references(reader *r, ss_scene_node *map, ss_case_mesh *mesh)
{
    if (map->kind != SS_SCENE_MAP) {
        ss_scene_node_fault(r->report, map, "must be a mapping 'material: file'");
        return;
    }
    for (ss_scene_node *node = map->first; node != NULL; node = node->next) {
        const int32_t m = find_material(r->out, node->key);
        if (m < 0) {
            ss_scene_key_fault(r->report, node, "no levels are given for this material");
        } else {
            get_text(r, node, mesh->reference[m], sizeof mesh->reference[m]);
        }
    }
}

static int32_t read_meshes(reader *r, ss_scene_node *map, ss_case_mesh *mesh)
{
    int32_t count = 0;
    if (map->kind != SS_SCENE_MAP || map->count == 0 || map->count > SS_CASE_MAX_MESHES) {
        ss_scene_node_fault(r->report, map, "must be a mapping of 1 to %d meshes",
                            SS_CASE_MAX_MESHES);
        return 0;
    }
    for (ss_scene_node *node = map->first; node != NULL; node = node->next) {
        ss_case_mesh *at = &mesh[count];
        if (strlen(node->key) >= sizeof at->name || !is_plain(node->key) ||
            !check_keys(r, node, "volume|surface|sets|reference")) {
            ss_scene_key_fault(r->report, node, "cannot be used as the name of a mesh");
            continue;
        }
        snprintf(at->name, sizeof at->name, "%s", node->key);
        take_text(r, node, "volume", at->volume, sizeof at->volume);
        take_text(r, node, "surface", at->surface, sizeof at->surface);
        ss_scene_node *sets = need(r, node, "sets");
        if (sets != NULL) {
            get_text(r, sets, at->sets, sizeof at->sets);
        }
        ss_scene_node *reference = ss_scene_node_find(node, "reference");
        if (reference != NULL) {
            read_references(r, reference, at);
        }
        if (at->volume[0] == '\0' && at->surface[0] == '\0') {
            ss_scene_node_fault(r->report, node, "has neither a volume nor a surface file");
        }
        ++count;
    }
    return count;
}

/* ---- dynamic cases ---- */

static void read_curve(ss_case *c, const char *name, ss_case_step *step, softsim_error *error)
{
    static const char *const axis[] = {"tip_ux_m", "tip_uy_m", "tip_uz_m"};
    char path[2 * SS_CASE_PATH];
    ss_table table;
    snprintf(path, sizeof path, "%s/%s", c->folder, name);
    softsim_status status = ss_table_load(path, &table, error);
    const int32_t time = status == SOFTSIM_OK ? ss_table_find(&table, "t_s", error) : -1;
    int32_t column[3] = {-1, -1, -1};
    for (int k = 0; k < 3 && time >= 0; ++k) {
        column[k] = ss_table_find(&table, axis[k], error);
    }
    if (time >= 0 && column[0] >= 0 && column[1] >= 0 && column[2] >= 0) {
        step->time = calloc((size_t)table.row_count + 1, sizeof *step->time);
        step->u = calloc((size_t)table.row_count + 1, sizeof *step->u);
        for (int32_t i = 0; i < table.row_count && step->time != NULL && step->u != NULL; ++i) {
            step->time[i] = ss_table_number(&table, i, time, error);
            for (int k = 0; k < 3; ++k) {
                step->u[i][k] = ss_table_number(&table, i, column[k], error);
            }
            if (i > 0 && !(step->time[i] > step->time[i - 1])) {
                softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s:%d: times must increase", path,
                                  table.line[i]);
                break;
            }
            step->count = i + 1;
        }
        if (step->count < 8) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s: fewer than 8 rows", path);
        } else if (step->time[step->count - 1] < step->until * (1.0 - 1e-9)) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                              "%s:%d: the last time is %g s, compare_until_s is %g: rows are "
                              "missing at the end",
                              path, table.line[step->count - 1], step->time[step->count - 1],
                              step->until);
        }
    }
    ss_table_fini(&table);
}

/* File names of the curves are read only once the YAML is found good. */
typedef struct dynamic_files {
    char step[SS_CASE_MAX_STEPS][SS_CASE_PATH];
    char modes[SS_CASE_PATH], mode_row[64], mode_column[32];
} dynamic_files;

static void read_modes(ss_case *c, const dynamic_files *files, softsim_error *error)
{
    char path[2 * SS_CASE_PATH];
    ss_table table;
    snprintf(path, sizeof path, "%s/%s", c->folder, files->modes);
    if (ss_table_load(path, &table, error) == SOFTSIM_OK) {
        const int32_t column = ss_table_find(&table, files->mode_column, error);
        const int32_t name = ss_table_find(&table, "model", error);
        for (int32_t i = 0; i < table.row_count && column >= 0 && name >= 0; ++i) {
            if (strcmp(ss_table_cell(&table, i, name), files->mode_row) == 0) {
                c->first_frequency = ss_table_number(&table, i, column, error);
            }
        }
        if (column >= 0 && name >= 0 && !(c->first_frequency > 0.0)) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s: no frequency above 0 of '%s'", path,
                              files->mode_row);
        }
    }
    ss_table_fini(&table);
}

static void read_step(reader *r, ss_scene_node *node, dynamic_files *files)
{
    ss_case *c = r->out;
    if (!check_keys(r, node, "gravity_m_s2|reference|compare_until_s")) {
        return;
    }
    ss_case_step *step = &c->step[c->step_count];
    ss_scene_node *gravity = need(r, node, "gravity_m_s2");
    ss_scene_node *reference = need(r, node, "reference");
    ss_scene_node *until = need(r, node, "compare_until_s");
    if (gravity != NULL && reference != NULL && until != NULL &&
        get_vector(r, gravity, step->gravity) &&
        get_number(r, until, 1e-6, longest_s, &step->until) &&
        get_text(r, reference, files->step[c->step_count], SS_CASE_PATH)) {
        ++c->step_count;
    }
}

static void read_dynamic(reader *r, ss_scene_node *root, dynamic_files *files)
{
    ss_case *c = r->out;
    ss_scene_node *probe = need(r, root, "probe_point_m");
    ss_scene_node *steps = need(r, root, "steps");
    ss_scene_node *modes = ss_scene_node_find(root, "modes");
    if (probe != NULL) {
        get_vector(r, probe, c->probe);
    }
    if (modes != NULL && check_keys(r, modes, "file|model|column")) {
        take_text(r, modes, "file", files->modes, sizeof files->modes);
        take_text(r, modes, "model", files->mode_row, sizeof files->mode_row);
        take_text(r, modes, "column", files->mode_column, sizeof files->mode_column);
    }
    if (steps != NULL && (steps->kind != SS_SCENE_LIST || steps->count > SS_CASE_MAX_STEPS)) {
        ss_scene_node_fault(r->report, steps, "must be a list of at most %d steps",
                            SS_CASE_MAX_STEPS);
    } else if (steps != NULL) {
        for (ss_scene_node *node = steps->first; node != NULL; node = node->next) {
            read_step(r, node, files);
        }
    }
}

/* ---- forces ---- */

/* A push whose table lacks a level is half a reference. */
static void check_forces(const ss_case *c, const char *path, softsim_error *error)
{
    for (int32_t i = 0; i < c->level_count; ++i) {
        const ss_case_level *level = &c->level[i];
        if (isnan(level->force)) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                              "%s: no row for %s at %.9g m, the level '%s' of case.yaml", path,
                              c->material[level->material], level->value, level->tag);
        }
    }
}

static void take_force(ss_case *c, const char *material, double value, double force)
{
    const int32_t m = find_material(c, material);
    for (int32_t i = 0; i < c->level_count; ++i) {
        ss_case_level *level = &c->level[i];
        if (level->material == m && fabs(level->value - value) <= 1e-6 * fabs(value)) {
            level->force = force;
        }
    }
}

static void read_forces(ss_case *c, const char *name, softsim_error *error)
{
    static const char *const axis[] = {"Fx_N", "Fy_N", "Fz_N"};
    char path[2 * SS_CASE_PATH];
    ss_table table;
    const int32_t faults = error->fault_count;
    snprintf(c->forces, sizeof c->forces, "%s", name);
    snprintf(path, sizeof path, "%s/%s", c->folder, name);
    if (ss_table_load(path, &table, error) == SOFTSIM_OK) {
        const int32_t material = ss_table_find(&table, "material", error);
        const int32_t depth = ss_table_find(&table, "depth_m", error);
        int32_t column[3];
        for (int k = 0; k < 3; ++k) {
            column[k] = ss_table_find(&table, axis[k], error);
        }
        for (int32_t i = 0; i < table.row_count && error->fault_count == faults; ++i) {
            double force[3];
            for (int k = 0; k < 3; ++k) {
                force[k] = ss_table_number(&table, i, column[k], error);
            }
            take_force(c, ss_table_cell(&table, i, material),
                       ss_table_number(&table, i, depth, error), ss_dot3(force, c->direction));
        }
        if (error->fault_count == faults) {
            check_forces(c, path, error);
        }
    }
    ss_table_fini(&table);
}

/* ---- the whole ---- */

typedef struct other_files {
    char forces[SS_CASE_PATH], mesh_case[SS_CASE_PATH];
    dynamic_files dynamic;
} other_files;

static void read_root(reader *r, ss_scene_node *root, other_files *files)
{
    static const char keys[] =
        "case|kind|material|fixed|prescribed|pressure|gravity_m_s2|levels|meshes|surface_meshes|"
        "force|mesh_case|probe_point_m|modes|steps";
    ss_case *c = r->out;
    char kind[16] = "static";
    check_keys(r, root, keys);
    ss_scene_node *name = need(r, root, "case");
    if (name != NULL && get_text(r, name, c->name, sizeof c->name) && !is_plain(c->name)) {
        ss_scene_node_fault(r->report, name, "names files: letters, digits and _.+- only");
    }
    take_text(r, root, "kind", kind, sizeof kind);
    take_text(r, root, "fixed", c->fixed, sizeof c->fixed);
    take_text(r, root, "force", files->forces, sizeof files->forces);
    take_text(r, root, "mesh_case", files->mesh_case, sizeof files->mesh_case);
    c->is_dynamic = strcmp(kind, "dynamic") == 0;
    if (!c->is_dynamic && strcmp(kind, "static") != 0) {
        ss_scene_node_fault(r->report, ss_scene_node_find(root, "kind"),
                            "must be static or dynamic");
    }
    read_material(r, root);
    read_push(r, root);
    if (c->is_dynamic) {
        read_dynamic(r, root, &files->dynamic);
    } else {
        read_levels(r, root);
    }
    ss_scene_node *meshes = ss_scene_node_find(root, "meshes");
    ss_scene_node *surfaces = ss_scene_node_find(root, "surface_meshes");
    if (meshes != NULL) {
        c->mesh_count = read_meshes(r, meshes, c->mesh);
    } else if (files->mesh_case[0] == '\0') {
        need(r, root, "meshes");
    }
    if (surfaces != NULL) {
        c->surface_mesh_count = read_meshes(r, surfaces, c->surface_mesh);
    }
}

static softsim_status load_case(const char *folder, bool is_other, ss_case *out,
                                softsim_error *error);

/* Takes the meshes of another case: their folder goes with them. */
static void take_meshes(ss_case *c, const char *relative, softsim_error *error)
{
    ss_case *other = calloc(1, sizeof *other);
    char folder[2 * SS_CASE_PATH];
    const int length = snprintf(folder, sizeof folder, "%s/%s", c->folder, relative);
    if (other == NULL || length >= SS_CASE_PATH) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: too long a path", folder);
    } else if (load_case(folder, true, other, error) == SOFTSIM_OK) {
        memcpy(c->mesh_folder, other->mesh_folder, sizeof c->mesh_folder);
        memcpy(c->mesh, other->mesh, sizeof c->mesh);
        memcpy(c->surface_mesh, other->surface_mesh, sizeof c->surface_mesh);
        c->mesh_count = other->mesh_count;
        c->surface_mesh_count = other->surface_mesh_count;
    }
    if (other != NULL) {
        ss_case_fini(other);
    }
    free(other);
}

static void read_other_files(ss_case *c, const other_files *files, bool is_other,
                             softsim_error *error)
{
    if (files->forces[0] != '\0') {
        read_forces(c, files->forces, error);
    }
    if (files->dynamic.modes[0] != '\0') {
        read_modes(c, &files->dynamic, error);
    }
    for (int32_t i = 0; i < c->step_count; ++i) {
        read_curve(c, files->dynamic.step[i], &c->step[i], error);
    }
    if (files->mesh_case[0] != '\0' && !is_other) {
        take_meshes(c, files->mesh_case, error);
    } else if (files->mesh_case[0] != '\0') {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s/case.yaml: mesh_case leads from case to case; name the one that has "
                          "the meshes",
                          c->folder);
    }
}

static softsim_status load_case(const char *folder, bool is_other, ss_case *out,
                                softsim_error *error)
{
    char path[SS_CASE_PATH + 16];
    *out = (ss_case){.first_frequency = (double)NAN};
    if (strlen(folder) >= sizeof out->folder) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%.80s...: too long a path", folder);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    snprintf(out->folder, sizeof out->folder, "%s", folder);
    memcpy(out->mesh_folder, out->folder, sizeof out->mesh_folder);
    snprintf(path, sizeof path, "%s/case.yaml", folder);
    size_t size = 0;
    char *text = ss_table_read_file(path, &size, error);
    ss_scene_report *report = calloc(1, sizeof *report);
    other_files *files = calloc(1, sizeof *files);
    if (text != NULL && (report == NULL || files == NULL)) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", folder);
    } else if (text != NULL) {
        const int32_t faults = error->fault_count;
        ss_scene_tree tree = {.root = NULL};
        *report = (ss_scene_report){.path = path, .source = text, .size = size};
        if (ss_scene_tree_parse(&tree, report, text, size)) {
            reader r = {.report = report, .out = out};
            read_root(&r, tree.root, files);
        }
        ss_scene_report_flush(report, error);
        ss_scene_tree_fini(&tree);
        if (error->fault_count == faults) {
            read_other_files(out, files, is_other, error);
        }
    }
    SS_EACH(free, files, report, text);
    return error->fault_count > 0 ? error->status : SOFTSIM_OK;
}

softsim_status ss_case_load(const char *folder, ss_case *out, softsim_error *error)
{
    return load_case(folder, false, out, error);
}

void ss_case_fini(ss_case *c)
{
    for (int32_t i = 0; i < SS_CASE_MAX_STEPS; ++i) {
        free(c->step[i].time);
        free(c->step[i].u);
        c->step[i].time = NULL;
        c->step[i].u = NULL;
    }
}

void ss_case_join(const char *folder, const char *name, char *out, size_t size)
{
    snprintf(out, size, name[0] == '/' ? "%.0s%s" : "%s/%s", folder, name);
}

/* `name` "": there is no such file. */
static bool check_file(const char *folder, const char *name, const ss_named_file *output,
                       int32_t output_count, softsim_error *error)
{
    char path[2 * SS_CASE_PATH];
    const ss_named_file input = {"a file of the case", path};
    ss_case_join(folder, name, path, sizeof path);
    return name[0] == '\0' || ss_files_check(&input, 1, output, output_count, error);
}

bool ss_case_check_outputs(const ss_case *c, const ss_named_file *output, int32_t output_count,
                           softsim_error *error)
{
    bool is_good = check_file(c->folder, "case.yaml", output, output_count, error) &&
                   check_file(c->mesh_folder, "case.yaml", output, output_count, error) &&
                   check_file(c->folder, c->forces, output, output_count, error);
    for (int32_t i = 0; i < c->mesh_count + c->surface_mesh_count && is_good; ++i) {
        const ss_case_mesh *mesh =
            i < c->mesh_count ? &c->mesh[i] : &c->surface_mesh[i - c->mesh_count];
        is_good = check_file(c->mesh_folder, mesh->volume, output, output_count, error) &&
                  check_file(c->mesh_folder, mesh->surface, output, output_count, error) &&
                  check_file(c->mesh_folder, mesh->sets, output, output_count, error);
        for (int32_t m = 0; m < SS_CASE_MAX_MATERIALS && is_good; ++m) {
            is_good = check_file(c->mesh_folder, mesh->reference[m], output, output_count, error);
        }
    }
    return is_good;
}

const ss_case_mesh *ss_case_meshes(const ss_case *c, bool on_surface, int32_t *out_count)
{
    const bool is_own = on_surface && c->surface_mesh_count > 0;
    *out_count = is_own ? c->surface_mesh_count : c->mesh_count;
    return is_own ? c->surface_mesh : c->mesh;
}

bool ss_case_has_body(const ss_case_mesh *mesh, bool on_surface)
{
    return (on_surface ? mesh->surface : mesh->volume)[0] != '\0';
}
