/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * From the checked tree to the scene: tools, mesh, node sets, parameters, loads.
 *
 * Order: text -> tree -> overrides -> tables (types, ranges, plain values) -> tools -> mesh ->
 * whatever needs the mesh. A part with a fault is left out and the rest goes on, so that one run
 * names every fault; only unreadable YAML ends it early, and an unusable mesh hides the faults of
 * the regions on it.
 */
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "rt/each.h"
#include "rt/files.h"
#include "rt/progress.h"
#include "scene/grid.h"
#include "scene/loader.h"
#include "scene/region.h"
#include "scene/source.h"

/* The node of a path below the root, usable: given, and without a fault in it. */
static ss_scene_node *good(ss_scene_node *node)
{
    return node != NULL && !node->is_faulty ? node : NULL;
}

/* ---- meshes and tools ---- */

/* The file's path, when it can be opened; else a fault with the place in the scene. */
static bool find_file(ss_scene_loader *l, ss_scene_node *node, char *out, size_t size)
{
    if (!ss_scene_join_path(l->space.folder, node->text, out, size)) {
        ss_scene_node_fault(l->report, node, "the path is too long");
        return false;
    }
    const char *why = NULL;
    const int fd = ss_files_open(out, NULL, &why);
    if (fd < 0) {
        ss_scene_node_fault(l->report, node,
                            "cannot open '%.200s': %s; paths are relative to the scene file",
                            node->text, why);
        return false;
    }
    close(fd);
    return true;
}

static double metres_of(const ss_scene_node *units)
{
    const ss_scene_row *object = ss_scene_find_row(ss_scene_root, "object");
    const ss_scene_row *row = ss_scene_find_row(object->child, "units");
    return ss_scene_unit_metres[ss_scene_choice(row->choices, units->text)];
}

static void take_convex(ss_scene_loader *l, const ss_scene_node *map, ss_shape *shape)
{
    char path[2048];
    ss_mesh *mesh = NULL;
    ss_scene_node *file = ss_scene_node_find(map, "file");
    ss_scene_node *units = good(ss_scene_node_find(map, "units"));
    if (units == NULL) {
        units = good(ss_scene_node_find(ss_scene_node_find(l->root, "object"), "units"));
    }
    if (units == NULL || !find_file(l, file, path, sizeof path)) {
        return;
    }
    softsim_error fault = {.status = SOFTSIM_OK};
    if (ss_mesh_load(path, metres_of(units), l->import_program, &mesh, l->mesh_error) ==
            SOFTSIM_OK &&
        ss_shape_init_convex(shape, mesh, &fault) != SOFTSIM_OK) {
        ss_scene_node_fault(l->report, file, "%s", fault.text);
    }
    ss_mesh_destroy(&mesh);
}

static void take_shape(ss_scene_loader *l, const ss_scene_node *map, ss_shape *shape)
{
    const double mm = 1e-3;
    const ss_scene_node *form = map->first;
    shape->radius = mm * ss_scene_get_number(form, "radius_mm", 0);
    shape->half_length = mm / 2 * ss_scene_get_number(form, "length_mm", 0);
    if (strcmp(form->key, "sphere") == 0) {
        shape->kind = SS_SHAPE_SPHERE;
    } else if (strcmp(form->key, "capsule") == 0) {
        shape->kind = SS_SHAPE_CAPSULE;
    } else if (strcmp(form->key, "cylinder") == 0) {
        shape->kind = SS_SHAPE_CYLINDER;
    } else if (strcmp(form->key, "cone") == 0) {
        shape->kind = SS_SHAPE_CONE;
    } else if (strcmp(form->key, "convex") == 0) {
        shape->kind = SS_SHAPE_CONVEX;
        take_convex(l, form, shape);
    } else {
        double size[3] = {0};
        ss_scene_get_vector(ss_scene_node_find(form, "size_mm"), size);
        shape->kind = SS_SHAPE_BOX;
        for (int k = 0; k < 3; k++) {
            shape->half_extent[k] = mm / 2 * size[k];
        }
    }
}

static void take_tools(ss_scene_loader *l)
{
    ss_scene_node *tools = ss_scene_node_find(ss_scene_node_find(l->root, "contact"), "tools");
    ss_scene_node *item = ss_scene_entry_count(tools) > 0 ? tools->first : NULL;
    for (; item != NULL; item = item->next) {
        if (item->is_faulty) {
            continue;
        }
        const int probe = (int)ss_scene_get_number(item, "probe", 0);
        ss_scene_tool *tool = &l->scene->tool[probe];
        if (tool->is_used) {
            ss_scene_node_fault(
                l->report, ss_scene_node_find(item, "probe"),
                "probe %d has a tool already; give each tool its own probe, 0 to %d", probe,
                SOFTSIM_MAX_PROBES - 1);
            continue;
        }
        tool->is_used = true;
        take_shape(l, ss_scene_node_find(item, "shape"), &tool->shape);
    }
}

static void transform(const ss_scene_node *object, ss_mesh *mesh)
{
    double rotate[3] = {0, 0, 0};
    double translate[3] = {0, 0, 0};
    const ss_scene_node *map = ss_scene_node_find(object, "transform");
    if (map != NULL) {
        ss_scene_get_vector(ss_scene_node_find(map, "rotate_deg"), rotate);
        ss_scene_get_vector(ss_scene_node_find(map, "translate_m"), translate);
        ss_mesh_transform(mesh, ss_scene_get_number(map, "scale", 1), rotate, translate);
    }
}

/* A mesh from a file of the object's. */
static bool load_mesh(ss_scene_loader *l, ss_scene_node *file, const ss_scene_node *units,
                      ss_mesh **out)
{
    char path[2048];
    if (!find_file(l, file, path, sizeof path) || units == NULL) {
        return false;
    }
    const int32_t before = l->mesh_error->fault_count;
    const softsim_status status =
        ss_mesh_load(path, metres_of(units), l->import_program, out, l->mesh_error);
    if (status != SOFTSIM_OK && l->mesh_error->fault_count == before) {
        softsim_error_add(l->mesh_error, status, "%s: error: %s", path,
                          softsim_status_text(status));
    }
    return status == SOFTSIM_OK;
}

static bool make_grid(ss_scene_loader *l, ss_scene_node *grid, const ss_scene_node *units)
{
    const double metres = units != NULL ? metres_of(units) : 0;
    return ss_scene_make_grid(&l->space, grid, metres, &l->scene->mesh, l->mesh_error);
}

/* A mesh beside the object's, in its units and place; NULL: a fault. */
static ss_mesh *load_beside(ss_scene_loader *l, const ss_scene_node *object, ss_scene_node *file)
{
    char path[2048];
    ss_mesh *mesh = NULL;
    const ss_scene_node *units = good(ss_scene_node_find(object, "units"));
    if (units != NULL && load_mesh(l, file, units, &mesh)) {
        transform(object, mesh);
        ss_scene_join_path(l->space.folder, file->text, path, sizeof path);
        if (ss_mesh_accept(mesh, path, l->mesh_error) == SOFTSIM_OK) {
            return mesh;
        }
    }
    ss_mesh_destroy(&mesh);
    return NULL;
}

static bool has_row(const ss_scene_model *model, const char *name)
{
    for (int32_t i = 0; model != NULL && i < model->row_count; i++) {
        if (strcmp(model->row[i].name, name) == 0) {
            return true;
        }
    }
    return false;
}

/* Does the model have a layer around its volume? */
static bool has_layer(const ss_scene_model *model)
{
    return has_row(model, "layer.thickness_m");
}

/* The finer surface that curved edges follow. */
static bool take_surface(ss_scene_loader *l, const ss_scene_node *object)
{
    ss_scene_node *file = good(ss_scene_node_find(object, "surface"));
    if (file != NULL && !has_row(l->model, "curved")) {
        ss_scene_node_fault(l->report, file,
                            "object.surface is what curved edges follow, which %s does not have; "
                            "fem-quadratic does",
                            l->model != NULL ? l->model->name : "this model");
        return false;
    }
    l->scene->surface = file != NULL ? load_beside(l, object, file) : NULL;
    return file == NULL || l->scene->surface != NULL;
}

/* The mesh with a layer's outer surface: the given one, or grown by a thickness. */
static bool take_layer(ss_scene_loader *l, ss_scene_node *object, const char *name)
{
    ss_scene *scene = l->scene;
    ss_scene_node *outer = good(ss_scene_node_find(object, "outer"));
    ss_scene_node *thickness =
        good(ss_scene_find_model_node(ss_scene_node_find(l->root, "model"), "layer.thickness_m"));
    if (outer != NULL && !has_layer(l->model)) {
        ss_scene_node_fault(l->report, outer,
                            "object.outer is for a layer around the mesh, which "
                            "%s does not have; hybrid does",
                            l->model != NULL ? l->model->name : "this model");
        return false;
    }
    if (outer != NULL && thickness != NULL) {
        ss_scene_node_fault(l->report, thickness,
                            "the layer reaches to object.outer; remove one of the two");
        return false;
    }
    if ((outer == NULL && thickness == NULL) || !has_layer(l->model)) {
        return true;
    }
    ss_mesh *core = scene->mesh;
    ss_mesh *layered = NULL;
    softsim_error *fault = calloc(1, sizeof *fault);
    softsim_status status = fault != NULL ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    if (status == SOFTSIM_OK && outer != NULL) {
        ss_mesh *surface = load_beside(l, object, outer);
        if (surface == NULL) {
            free(fault);
            return false;
        }
        status = ss_mesh_add_skin(core, surface, &layered, fault);
        ss_mesh_destroy(&surface);
    } else if (status == SOFTSIM_OK) {
        const double metres = strtod(thickness->text, NULL);
        status = metres != 0.0 ? ss_mesh_grow_skin(core, metres, &layered, fault) : SOFTSIM_OK;
        if (metres == 0.0) {
            ss_scene_node_fault(l->report, thickness,
                                "a layer of no thickness has no particles; "
                                "give more, or less, than 0");
        }
    }
    if (status != SOFTSIM_OK) {
        softsim_error_add(l->mesh_error, status, "%s: error: %s", name,
                          fault != NULL ? fault->text : softsim_status_text(status));
    }
    free(fault);
    if (layered != NULL) {
        ss_mesh_destroy(&scene->mesh);
        scene->mesh = layered;
    }
    return layered != NULL;
}

/* Loads or makes, transforms and judges the mesh; on success the regions can be resolved. */
static bool take_mesh(ss_scene_loader *l)
{
    ss_scene_node *object = ss_scene_node_find(l->root, "object");
    ss_scene_node *file = good(ss_scene_node_find(object, "mesh"));
    ss_scene_node *grid = good(ss_scene_node_find(object, "grid"));
    ss_scene_node *units = good(ss_scene_node_find(object, "units"));
    ss_scene_node *map = ss_scene_node_find(object, "transform");
    ss_scene_node *repair = good(ss_scene_node_find(object, "repair"));
    ss_scene_node *source = file != NULL ? file : grid;
    if (source == NULL || (map != NULL && map->is_faulty) ||
        (file != NULL ? !load_mesh(l, file, units, &l->scene->mesh) : !make_grid(l, grid, units))) {
        return false;
    }
    ss_scene *scene = l->scene;
    transform(object, scene->mesh);
    if (repair != NULL && strcmp(repair->text, "true") == 0) {
        ss_mesh *mended = NULL;
        if (ss_mesh_repair(scene->mesh, &mended, &scene->repairs, l->mesh_error) != SOFTSIM_OK) {
            return false;
        }
        ss_mesh_destroy(&scene->mesh);
        scene->mesh = mended;
    }
    if (l->model != NULL && l->model->needs_volume && scene->mesh->tetrahedron_count == 0) {
        ss_scene_node_fault(l->report, source,
                            "%s needs a volume, and '%.100s' is a surface; make tetrahedra with "
                            "softsim-mesh tetrahedralize",
                            l->model->name, file != NULL ? file->text : "object.grid");
    }
    if (l->model != NULL && !l->model->takes_second_order && file != NULL &&
        scene->mesh->middle != NULL) {
        ss_scene_node_fault(l->report, source,
                            "%s has no mid-edge nodes, and '%.100s' is of second "
                            "order; take fem-quadratic, or a mesh of its corners: softsim-mesh "
                            "convert --order 1",
                            l->model->name, file->text);
    }
    char name[2048];
    if (file != NULL) {
        ss_scene_join_path(l->space.folder, file->text, name, sizeof name);
    } else {
        snprintf(name, sizeof name, "%s: object.grid", l->report->path);
    }
    ss_progress_part("checking the mesh, %d nodes", scene->mesh->node_count);
    if (ss_mesh_accept(scene->mesh, name, l->mesh_error) != SOFTSIM_OK ||
        (scene->mesh->tetrahedron_count > 0 && !take_layer(l, object, name)) ||
        !take_surface(l, object)) {
        return false;
    }
    const int32_t node_count = scene->mesh->node_count;
    l->space.mesh = scene->mesh;
    l->space.tolerance = 1e-9 * ss_mesh_diagonal(scene->mesh);
    l->space.mask = calloc((size_t)node_count, 1);
    scene->fixed = calloc((size_t)node_count, 1);
    if (l->space.mask == NULL || scene->fixed == NULL) {
        ss_scene_fault_memory(l);
        return false;
    }
    return true;
}

/* ---- fixed nodes, parameters ---- */

static void take_fixed(ss_scene_loader *l)
{
    ss_scene_node *list = ss_scene_node_find(ss_scene_node_find(l->root, "object"), "fixed");
    ss_scene_node *item = ss_scene_entry_count(list) > 0 ? list->first : NULL;
    for (; item != NULL; item = item->next) {
        if (item->is_faulty || ss_scene_select(&l->space, item) < 0) {
            continue;
        }
        const uint8_t axes = ss_scene_axes_of(item);
        for (int32_t i = 0; i < l->scene->mesh->node_count; i++) {
            l->scene->fixed[i] |= l->space.mask[i] ? axes : 0;
        }
    }
}

/* A uniform direction, or one per element. */
static void take_direction(ss_scene_loader *l, ss_scene_node *node, ss_param_value *value,
                           bool has_mesh)
{
    if (node->kind == SS_SCENE_LIST) {
        ss_scene_get_vector(node, value->direction);
        ss_scene_normalise(value->direction);
    } else if (has_mesh) {
        const size_t count = (size_t)ss_mesh_element_count(l->scene->mesh);
        value->per_element = calloc(count, sizeof *value->per_element);
        if (value->per_element == NULL) {
            ss_scene_fault_memory(l);
            return;
        }
        ss_scene_read_directions(&l->space, node, value->per_element);
    }
}

/* A value per node, or per element. */
static void take_field(ss_scene_loader *l, const ss_scene_row *row, ss_scene_node *node,
                       ss_param_value *value)
{
    const ss_mesh *mesh = l->scene->mesh;
    bool is_element = false;
    value->per_node = calloc((size_t)mesh->node_count, sizeof *value->per_node);
    value->by_element = row->takes_elements
                            ? calloc((size_t)ss_mesh_element_count(mesh), sizeof *value->by_element)
                            : NULL;
    if (value->per_node == NULL || (row->takes_elements && value->by_element == NULL)) {
        ss_scene_fault_memory(l);
        return;
    }
    ss_scene_read_field(&l->space, row, node, value->per_node, value->by_element, &is_element);
    double **const unused = is_element ? &value->per_node : &value->by_element;
    free(*unused);
    *unused = NULL;
}

/* Rows of the model's table; those that vary over the mesh need it. */
static void take_parameters(ss_scene_loader *l, bool has_mesh)
{
    ss_scene *scene = l->scene;
    const ss_scene_node *map = ss_scene_node_find(l->root, "model");
    scene->param = calloc((size_t)l->model->row_count + 1, sizeof *scene->param);
    if (scene->param == NULL) {
        ss_scene_fault_memory(l);
        return;
    }
    for (int32_t i = 0; i < l->model->row_count; i++) {
        const ss_scene_row *row = &scene->source->model_row[i + 1];
        ss_param_value *value = &scene->param[i];
        ss_scene_node *node = ss_scene_find_model_node(map, row->name);
        value->number = row->fallback;
        value->is_given = node != NULL;
        if (good(node) == NULL) {
            continue;
        }
        if (row->kind == SS_SCENE_DIRECTION) {
            take_direction(l, node, value, has_mesh);
        } else if (node->kind == SS_SCENE_SCALAR) {
            char why[96];
            ss_scene_read_scalar(row, node->text, node->is_quoted, &value->number, why, sizeof why);
        } else if (has_mesh && (value->link_count = ss_scene_read_links(&l->space, row, node,
                                                                        &value->per_link)) != 0) {
            continue; /* by link, or at fault */
        } else if (has_mesh) {
            take_field(l, row, node, value);
        }
    }
}

static void take_friction(ss_scene_loader *l, bool has_mesh)
{
    const ss_scene_node *map = good(ss_scene_node_find(l->root, "contact"));
    ss_scene_node *node = map != NULL ? good(ss_scene_node_find(map, "friction")) : NULL;
    if (node == NULL) {
        return;
    }
    const ss_scene_row *contact = ss_scene_find_row(ss_scene_root, "contact");
    const ss_scene_row *row = ss_scene_find_row(contact->child, "friction");
    ss_param_value *value = &l->scene->friction;
    value->is_given = true;
    if (node->kind == SS_SCENE_SCALAR) {
        char why[96];
        ss_scene_read_scalar(row, node->text, node->is_quoted, &value->number, why, sizeof why);
    } else if (has_mesh) {
        take_field(l, row, node, value);
    }
}

/* ---- the whole ---- */

void ss_scene_destroy(ss_scene **scene_pointer)
{
    ss_scene *scene = scene_pointer != NULL ? *scene_pointer : NULL;
    if (scene == NULL) {
        return;
    }
    for (int32_t i = 0; i < scene->load_count; i++) {
        free(scene->load[i].node);
    }
    for (int32_t i = 0; i < scene->prescribed_count; i++) {
        free(scene->prescribed[i].node);
        free(scene->prescribed[i].displacement);
    }
    for (int32_t i = 0; scene->param != NULL && i < scene->source->model_row_count - 1; i++) {
        SS_EACH(free, scene->param[i].per_node, scene->param[i].by_element,
                scene->param[i].per_link, scene->param[i].per_element);
    }
    for (int i = 0; i < SOFTSIM_MAX_PROBES; i++) {
        if (scene->tool[i].is_used) {
            ss_shape_fini(&scene->tool[i].shape);
        }
    }
    if (scene->source != NULL) {
        ss_scene_tree_fini(&scene->source->tree);
        free(scene->source->model_row);
    }
    ss_mesh_destroy(&scene->mesh);
    ss_mesh_destroy(&scene->surface);
    SS_EACH(free, scene->load, scene->prescribed, scene->param, scene->friction.per_node,
            scene->fixed, scene->source, scene);
    *scene_pointer = NULL;
}

static ss_scene *create(const char *path)
{
    ss_scene *scene = calloc(1, sizeof *scene);
    if (scene == NULL || (scene->source = calloc(1, sizeof *scene->source)) == NULL) {
        free(scene);
        return NULL;
    }
    const char *slash = strrchr(path, '/');
    const int folder = slash != NULL ? (int)(slash - path) + 1 : 0;
    snprintf(scene->path, sizeof scene->path, "%s", path);
    snprintf(scene->source->folder, sizeof scene->source->folder, "%.*s", folder, path);
    ss_scene_set_defaults(scene);
    return scene;
}

/* Everything below the tables; faults go to the report and to mesh_error. */
static void resolve(ss_scene_loader *l)
{
    take_tools(l);
    const bool has_mesh = take_mesh(l);
    take_friction(l, has_mesh);
    if (l->model != NULL) {
        take_parameters(l, has_mesh);
    }
    if (has_mesh) {
        take_fixed(l);
        ss_scene_take_loads(l);
        ss_scene_take_prescribed(l);
    }
    free(l->space.mask);
}

/* Each line of `from` becomes a fault of `error`. */
static void add_lines(softsim_error *error, softsim_error *from)
{
    for (char *line = from->text; from->fault_count > 0 && line != NULL;) {
        char *end = strchr(line, '\n');
        if (end != NULL) {
            *end = '\0';
        }
        softsim_error_append(error, from->status, line);
        line = end != NULL ? end + 1 : NULL;
    }
}

softsim_status ss_scene_load_text(const char *path, const char *text, size_t size,
                                  const char *const *overrides, int32_t override_count,
                                  const ss_scene_model *models, int32_t model_count,
                                  const char *import_program, ss_scene **out_scene,
                                  softsim_error *error)
{
    *out_scene = NULL;
    if (strlen(path) >= sizeof((ss_scene *)NULL)->path) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "the path of the scene is too long");
        return SOFTSIM_ERROR_ARGUMENT;
    }
    ss_scene *scene = create(path);
    ss_scene_report *report = calloc(1, sizeof *report);
    softsim_error *mesh_error = calloc(1, sizeof *mesh_error);
    if (scene == NULL || report == NULL || mesh_error == NULL) {
        ss_scene_destroy(&scene);
        free(report);
        free(mesh_error);
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
        return SOFTSIM_ERROR_MEMORY;
    }
    *report = (ss_scene_report){.path = path, .source = text, .size = size, .overrides = overrides};
    ss_scene_tree *tree = &scene->source->tree;
    if (ss_scene_tree_parse(tree, report, text, size)) {
        for (int32_t i = 0; i < override_count; i++) {
            ss_scene_tree_override(tree, report, i);
        }
        ss_scene_check check = {
            .report = report, .models = models, .model_count = model_count, .scene = scene};
        ss_scene_check_tree(&check, tree->root);
        scene->source->model_row = check.model_row;
        scene->source->model_row_count = check.model_row_count;
        ss_scene_loader l = {
            .report = report,
            .scene = scene,
            .model = check.model_row_count > 0 ? &models[scene->model_index] : NULL,
            .root = tree->root,
            .space = {.report = report, .folder = scene->source->folder, .scene = scene},
            .mesh_error = mesh_error,
            .import_program = import_program};
        resolve(&l);
    }
    const bool is_good = ss_scene_report_total(report) + mesh_error->fault_count == 0;
    softsim_status status = report->count > 0 ? report->fault[0].status : mesh_error->status;
    ss_scene_report_flush(report, error);
    add_lines(error, mesh_error);
    free(report);
    free(mesh_error);
    if (!is_good) {
        ss_scene_destroy(&scene);
        return status != SOFTSIM_OK ? status : SOFTSIM_ERROR_SCENE;
    }
    *out_scene = scene;
    return SOFTSIM_OK;
}

char *ss_scene_read_file(const char *path, size_t *out_size, softsim_error *error)
{
    int64_t size = 0;
    const char *why = NULL;
    FILE *stream = ss_files_open_stream(path, &size, &why);
    if (stream == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: error: cannot open: %s", path, why);
        return NULL;
    }
    char *text = NULL;
    if (size > SS_SCENE_MAX_BYTES) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s: error: larger than %d MB; put long lists into files of their own",
                          path, SS_SCENE_MAX_BYTES >> 20);
    } else if ((text = malloc((size_t)size + 1)) == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: error: out of memory", path);
    } else {
        *out_size = fread(text, 1, (size_t)size, stream);
        text[*out_size] = '\0';
    }
    fclose(stream);
    return text;
}

softsim_status ss_scene_load(const char *path, const char *const *overrides, int32_t override_count,
                             const ss_scene_model *models, int32_t model_count,
                             const char *import_program, ss_scene **out_scene, softsim_error *error)
{
    size_t size = 0;
    *out_scene = NULL;
    softsim_error local = {0};
    char *text = ss_scene_read_file(path, &size, &local);
    if (text == NULL) {
        softsim_error_append(error, local.status, local.text);
        return local.status;
    }
    const softsim_status status =
        ss_scene_load_text(path, text, size, overrides, override_count, models, model_count,
                           import_program, out_scene, error);
    free(text);
    return status;
}
