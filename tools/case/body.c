/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The body of a case on one of its meshes. Sets and references name nodes by the numbers of the
 * volume's file; our nodes count from 0 in the file's order, so a sorted list leads from one to the
 * other. A volume's numbers are read here from its $Nodes (MSH 2.2, or 4.1), since the mesh reader
 * rightly forgets them.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "case/case.h"
#include "case/table.h"
#include "rt/each.h"
#include "rt/order.h"
#include "rt/vec.h"
#include "scene/report.h"
#include "scene/tree.h"

enum { LONG_PATH = 2 * SS_CASE_PATH };
#define PLACE_SHARE 1e-3 /* of the body's diagonal: further off a node is another one */

typedef struct numbered {
    int32_t number, node;
} numbered;

typedef struct loader {
    const ss_case *c;
    const ss_case_mesh *mesh;
    ss_case_body *body;
    numbered *sorted; /* by number */
    softsim_error *error;
} loader;

static void no_memory(loader *l)
{
    softsim_error_add(l->error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", l->mesh->name);
}

static void join(const loader *l, const char *name, char out[LONG_PATH])
{
    ss_case_join(l->c->mesh_folder, name, out, LONG_PATH);
}

static int by_number(const void *a, const void *b)
{
    const numbered *x = a, *y = b;
    return ss_order_int(x->number, y->number);
}

/* -1: no node has that number. */
static int32_t find_node(const loader *l, double number)
{
    const numbered key = {
        .number = number >= 0.0 && number < 2e9 && number == floor(number) ? (int32_t)number : -1};
    const numbered *at =
        bsearch(&key, l->sorted, (size_t)l->body->mesh->node_count, sizeof *l->sorted, by_number);
    return at != NULL ? at->node : -1;
}

static bool sort_numbers(loader *l, const char *path)
{
    const int32_t count = l->body->mesh->node_count;
    l->sorted = calloc((size_t)count + 1, sizeof *l->sorted);
    if (l->sorted == NULL) {
        no_memory(l);
        return false;
    }
    for (int32_t i = 0; i < count; ++i) {
        l->sorted[i] = (numbered){.number = l->body->number[i], .node = i};
    }
    qsort(l->sorted, (size_t)count, sizeof *l->sorted, by_number);
    for (int32_t i = 1; i < count; ++i) {
        if (l->sorted[i].number == l->sorted[i - 1].number) {
            softsim_error_add(l->error, SOFTSIM_ERROR_FORMAT, "%s: two nodes have number %d", path,
                              l->sorted[i].number);
            return false;
        }
    }
    return true;
}

/* ---- volumes ---- */

static const char *next_line(const char *at)
{
    at = strchr(at, '\n');
    return at != NULL ? at + 1 : NULL;
}

/* The numbers in $Nodes: of version 2 before each position, of version 4 in blocks of their own.
 * The mesh was read already, so the section is sound. */
static void read_numbers(const char *text, int32_t count, int32_t *out)
{
    const char *format = strstr(text, "$MeshFormat");
    format = format != NULL ? next_line(format) : NULL; /* lines may end as on other systems */
    const bool is_blocked = format != NULL && strtod(format, NULL) >= 4.0;
    const char *at = strstr(text, "$Nodes");
    at = at != NULL ? next_line(at) : NULL;
    at = at != NULL ? next_line(at) : NULL;
    for (int32_t i = 0; at != NULL && i < count;) {
        long block = count;
        if (is_blocked) { /* dimension, entity, parametric, nodes */
            char *end = NULL;
            strtol(at, &end, 10);
            strtol(end, &end, 10);
            strtol(end, &end, 10);
            block = strtol(end, NULL, 10);
            at = next_line(at);
        }
        for (long k = 0; k < block && at != NULL && i < count; ++k, at = next_line(at)) {
            out[i++] = (int32_t)strtol(at, NULL, 10);
        }
        for (long k = 0; k < block && at != NULL && is_blocked; ++k) {
            at = next_line(at);
        }
    }
}

static bool load_volume(loader *l)
{
    char path[LONG_PATH];
    size_t size = 0;
    join(l, l->mesh->volume, path);
    char *text = ss_table_read_file(path, &size, l->error);
    bool is_good = text != NULL &&
                   ss_mesh_read_msh(text, size, path, 1.0, &l->body->mesh, l->error) == SOFTSIM_OK;
    if (is_good && l->body->mesh->tetrahedron_count == 0) {
        softsim_error_add(l->error, SOFTSIM_ERROR_MESH, "%s: holds no tetrahedra", path);
        is_good = false;
    }
    is_good = is_good && ss_mesh_accept(l->body->mesh, path, l->error) == SOFTSIM_OK;
    if (is_good) {
        l->body->number = calloc((size_t)l->body->mesh->node_count, sizeof *l->body->number);
        if (l->body->number == NULL) {
            no_memory(l);
            is_good = false;
        } else {
            read_numbers(text, l->body->mesh->node_count, l->body->number);
            is_good = sort_numbers(l, path);
        }
    }
    free(text);
    return is_good;
}

/* ---- surfaces ---- */

typedef struct surface_file {
    double (*position)[3];
    int32_t *number, *new_node; /* of each vertex */
    int32_t (*triangle)[3];
    int32_t vertex_count, triangle_count;
} surface_file;

static bool read_vertex(const char *line, surface_file *s)
{
    double *x = s->position[s->vertex_count];
    char *end = NULL;
    for (int k = 0; k < 3; ++k) {
        const char *from = k == 0 ? line + 1 : end;
        x[k] = strtod(from, &end);
        if (end == from || !isfinite(x[k])) {
            return false;
        }
    }
    const size_t length = strcspn(end, "\n");
    const char *note = memmem(end, length, "# node ", 7);
    s->number[s->vertex_count] = note != NULL ? atoi(note + 7) : s->vertex_count + 1;
    ++s->vertex_count;
    return true;
}

/* Corners are v, v/vt or v/vt/vn; faces of more than three are cut into a fan. */
static bool read_face(const char *line, surface_file *s, int64_t room)
{
    int32_t corner[3] = {0};
    int32_t count = 0;
    const char *at = line + 1;
    for (;;) {
        char *end = NULL;
        const long vertex = strtol(at, &end, 10);
        if (end == at) {
            return count >= 3;
        }
        if (vertex < 1 || vertex > s->vertex_count) {
            return false;
        }
        corner[count < 2 ? count : 2] = (int32_t)vertex - 1;
        if (++count >= 3) {
            if (s->triangle_count == room) {
                return false;
            }
            memcpy(s->triangle[s->triangle_count++], corner, sizeof corner);
            corner[1] = corner[2];
        }
        at = end + strcspn(end, " \t\r\n");
        at += strspn(at, " \t");
        if (*at == '\n' || *at == '\r' || *at == '\0') {
            return count >= 3;
        }
    }
}

static int64_t count_lines(const char *text)
{
    int64_t count = 1;
    for (const char *at = text; at != NULL; at = next_line(at)) {
        ++count;
    }
    return count;
}

static bool read_obj(loader *l, const char *text, const char *path, surface_file *s)
{
    const int64_t lines = count_lines(text), room = 4 * lines;
    if (room > INT32_MAX) {
        softsim_error_add(l->error, SOFTSIM_ERROR_FORMAT,
                          "%s: more than %d lines; give a coarser surface", path, INT32_MAX / 4);
        return false;
    }
    s->position = calloc((size_t)lines, sizeof *s->position);
    s->number = calloc((size_t)lines, sizeof *s->number);
    s->new_node = calloc((size_t)lines, sizeof *s->new_node);
    s->triangle = calloc((size_t)room, sizeof *s->triangle);
    if (!s->position || !s->number || !s->new_node || !s->triangle) {
        no_memory(l);
        return false;
    }
    int64_t number = 1;
    for (const char *at = text; at != NULL; at = next_line(at), ++number) {
        const bool is_vertex = strncmp(at, "v ", 2) == 0, is_face = strncmp(at, "f ", 2) == 0;
        if ((is_vertex && !read_vertex(at, s)) || (is_face && !read_face(at, s, room))) {
            softsim_error_add(l->error, SOFTSIM_ERROR_FORMAT, "%s:%lld: not a %s", path,
                              (long long)number,
                              is_vertex ? "vertex" : "face of vertices that there are");
            return false;
        }
    }
    return true;
}

/* Vertices without a face are left out. */
static bool build_surface(loader *l, surface_file *s)
{
    int32_t count = 0;
    for (int32_t t = 0; t < s->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            s->new_node[s->triangle[t][k]] = 1;
        }
    }
    for (int32_t v = 0; v < s->vertex_count; ++v) {
        if (s->new_node[v] == 0) {
            continue;
        }
        memmove(s->position[count], s->position[v], sizeof s->position[v]);
        s->number[count] = s->number[v];
        s->new_node[v] = count++;
    }
    for (int32_t t = 0; t < s->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            s->triangle[t][k] = s->new_node[s->triangle[t][k]];
        }
    }
    if (ss_mesh_create(count, (const double(*)[3])s->position, s->triangle_count,
                       (const int32_t(*)[3])s->triangle, 0, NULL, &l->body->mesh,
                       l->error) != SOFTSIM_OK) {
        return false;
    }
    l->body->number = calloc((size_t)count + 1, sizeof *l->body->number);
    l->body->weight = calloc((size_t)count + 1, sizeof *l->body->weight);
    if (l->body->number == NULL || l->body->weight == NULL) {
        no_memory(l);
        return false;
    }
    memcpy(l->body->number, s->number, (size_t)count * sizeof *s->number);
    ss_mesh_node_areas(l->body->mesh, l->body->weight);
    return true;
}

static bool load_surface(loader *l)
{
    char path[LONG_PATH];
    size_t size = 0;
    surface_file s = {.position = NULL};
    join(l, l->mesh->surface, path);
    char *text = ss_table_read_file(path, &size, l->error);
    bool is_good = text != NULL && read_obj(l, text, path, &s);
    if (is_good && s.triangle_count == 0) {
        softsim_error_add(l->error, SOFTSIM_ERROR_MESH, "%s: holds no faces", path);
        is_good = false;
    }
    is_good = is_good && build_surface(l, &s) && sort_numbers(l, path) &&
              ss_mesh_accept(l->body->mesh, path, l->error) == SOFTSIM_OK;
    SS_EACH(free, s.position, s.number, s.new_node, s.triangle, text);
    return is_good;
}

/* ---- sets ---- */

typedef struct set_reader {
    loader *l;
    ss_scene_report *report;
    ss_scene_node *root;
    bool on_surface;
} set_reader;

/* Nodes of a set; with `profile`, which goes in step with the set, also its values. On a surface,
 * nodes within the body are left out. Returns their number. */
static int32_t read_set(set_reader *r, const char *name, const char *profile, int32_t **out_node,
                        double **out_value)
{
    if (name[0] == '\0') {
        return 0;
    }
    ss_scene_node *set = ss_scene_node_find(r->root, name);
    ss_scene_node *values = profile[0] != '\0' ? ss_scene_node_find(r->root, profile) : NULL;
    if (set == NULL || set->kind != SS_SCENE_LIST || set->count == 0) {
        ss_scene_node_fault(r->report, set != NULL ? set : r->root,
                            "the case needs '%s', a list of node numbers", name);
        return 0;
    }
    if (profile[0] != '\0' &&
        (values == NULL || values->kind != SS_SCENE_LIST || values->count != set->count)) {
        ss_scene_node_fault(r->report, values != NULL ? values : r->root,
                            "the case needs '%s', a value for each of the %d nodes of '%s'",
                            profile, set->count, name);
        return 0;
    }
    *out_node = calloc((size_t)set->count, sizeof **out_node);
    double *value = calloc((size_t)set->count, sizeof *value);
    int32_t count = 0;
    if (*out_node == NULL || value == NULL) {
        no_memory(r->l);
        free(value);
        return 0;
    }
    const ss_scene_node *beside = values != NULL ? values->first : NULL;
    for (ss_scene_node *at = set->first; at != NULL;
         at = at->next, beside = beside != NULL ? beside->next : NULL) {
        double number = -1.0, share = 1.0;
        const bool is_number =
            at->kind == SS_SCENE_SCALAR &&
            ss_scene_parse_number(at->text, &number) == SS_SCENE_GOOD &&
            (beside == NULL || ss_scene_parse_number(beside->text != NULL ? beside->text : "",
                                                     &share) == SS_SCENE_GOOD);
        const int32_t node = is_number ? find_node(r->l, number) : -1;
        if (node >= 0) {
            (*out_node)[count] = node;
            value[count++] = share;
        } else if (!is_number || !r->on_surface) {
            ss_scene_node_fault(r->report, at, "is no node of the mesh, or has no good value");
            break;
        }
    }
    if (out_value != NULL) {
        *out_value = value;
    } else {
        free(value);
    }
    return count;
}

/* A node that is fixed and pushed has no displacement to be judged by. */
static void check_overlap(set_reader *r, const char *path)
{
    const ss_case_body *b = r->l->body;
    uint8_t *mark = calloc((size_t)b->mesh->node_count, 1);
    if (mark == NULL) {
        no_memory(r->l);
        return;
    }
    for (int32_t i = 0; i < b->fixed_count; ++i) {
        mark[b->fixed[i]] = 1;
    }
    for (int32_t i = 0; i < b->pushed_count; ++i) {
        if (mark[b->pushed[i]] != 0) {
            softsim_error_add(r->l->error, SOFTSIM_ERROR_FORMAT,
                              "%s: node %d is in '%s' and in '%s', or twice there", path,
                              b->number[b->pushed[i]], r->l->c->fixed, r->l->c->pushed);
            break;
        }
        mark[b->pushed[i]] = 1;
    }
    free(mark);
}

static void read_sets(loader *l, bool on_surface)
{
    char path[LONG_PATH];
    size_t size = 0;
    join(l, l->mesh->sets, path);
    char *text = ss_table_read_file(path, &size, l->error);
    ss_scene_report *report = calloc(1, sizeof *report);
    if (report == NULL) {
        no_memory(l);
    }
    if (text != NULL && report != NULL) {
        ss_scene_tree tree = {.root = NULL};
        *report = (ss_scene_report){.path = path, .source = text, .size = size};
        if (ss_scene_tree_parse(&tree, report, text, size)) {
            const ss_case *c = l->c;
            ss_case_body *b = l->body;
            set_reader r = {.l = l, .report = report, .root = tree.root, .on_surface = on_surface};
            b->fixed_count = read_set(&r, c->fixed, "", &b->fixed, NULL);
            b->pushed_count = read_set(&r, c->pushed, c->profile, &b->pushed, &b->profile);
            b->pressed_count = read_set(&r, c->pressed, "", &b->pressed, NULL);
            check_overlap(&r, path);
        }
        ss_scene_report_flush(report, l->error);
        ss_scene_tree_fini(&tree);
    }
    free(report);
    free(text);
}

/* ---- the reference ---- */

/* Errors are fractions of the reference: it must have a size. */
static bool has_measure(loader *l, const ss_table *table, int32_t level)
{
    const ss_case_body *b = l->body;
    double square = 0.0;
    for (int32_t i = 0; i < b->mesh->node_count; ++i) {
        square += b->weight[i] * ss_dot3(b->reference[level][i], b->reference[level][i]);
    }
    if (!(square > 0.0) || !isfinite(square)) {
        softsim_error_add(l->error, SOFTSIM_ERROR_FORMAT,
                          "%s: the displacements of level '%s' have %s: there is nothing to "
                          "measure an error by",
                          table->path, l->c->level[level].tag,
                          square > 0.0 ? "no finite size" : "no size, or no weight");
        return false;
    }
    return true;
}

static bool read_level(loader *l, const ss_table *table, const int32_t *node, int32_t level)
{
    static const char axes[] = "xyz";
    const ss_case_body *b = l->body;
    double(*u)[3] = calloc((size_t)b->mesh->node_count, sizeof *u);
    b->reference[level] = u;
    if (u == NULL) {
        no_memory(l);
        return false;
    }
    for (int k = 0; k < 3; ++k) {
        char name[48];
        snprintf(name, sizeof name, "u%c_%s", axes[k], l->c->level[level].tag);
        const int32_t column = ss_table_find(table, name, l->error);
        for (int32_t i = 0; i < table->row_count && column >= 0; ++i) {
            if (node[i] >= 0) {
                u[node[i]][k] = ss_table_number(table, i, column, l->error);
                if (isnan(u[node[i]][k])) {
                    return false;
                }
            }
        }
        if (column < 0) {
            return false;
        }
    }
    return has_measure(l, table, level);
}

/* The node of row i, into node[i]; -1 for those that the surface does not have. */
static bool match_row(loader *l, const ss_table *table, int32_t column, int32_t i, uint8_t *mark,
                      int32_t *node)
{
    const double number = ss_table_number(table, i, column, l->error);
    node[i] = find_node(l, number);
    if (isnan(number)) {
        return false;
    }
    if (node[i] < 0 && l->body->mesh->tetrahedron_count > 0) {
        softsim_error_add(l->error, SOFTSIM_ERROR_FORMAT,
                          "%s:%d: the mesh has no node %.9g: this is no table of %s", table->path,
                          table->line[i], number, l->mesh->volume);
        return false;
    }
    if (node[i] >= 0 && mark[node[i]]++ != 0) {
        softsim_error_add(l->error, SOFTSIM_ERROR_FORMAT, "%s:%d: a second row for node %.9g",
                          table->path, table->line[i], number);
        return false;
    }
    return true;
}

/* Every node needs a row, and one only; a volume's table has no others. */
static bool match_rows(loader *l, const ss_table *table, int32_t *node)
{
    const int32_t column = ss_table_find(table, "node", l->error);
    const int32_t count = l->body->mesh->node_count;
    uint8_t *mark = calloc((size_t)count + 1, 1);
    int32_t found = 0;
    bool is_good = column >= 0 && mark != NULL;
    if (mark == NULL) {
        no_memory(l);
    }
    for (int32_t i = 0; i < table->row_count && is_good; ++i) {
        is_good = match_row(l, table, column, i, mark, node);
        found += node[i] >= 0;
    }
    free(mark);
    if (is_good && found < count) {
        softsim_error_add(
            l->error, SOFTSIM_ERROR_FORMAT,
            "%s: only %d of the mesh's %d nodes have a row: the file is cut short, or "
            "of another mesh",
            table->path, found, count);
        is_good = false;
    }
    return is_good;
}

/* Where a table has positions they are the mesh's: node numbers alone fit many meshes. */
static bool check_positions(loader *l, const ss_table *table, const int32_t *node)
{
    static const char *const axes[] = {"x", "y", "z"};
    const ss_mesh *mesh = l->body->mesh;
    const double far = PLACE_SHARE * ss_mesh_diagonal(mesh);
    for (int k = 0; k < 3; ++k) {
        const int32_t column = ss_table_find(table, axes[k], NULL);
        for (int32_t i = 0; i < table->row_count && column >= 0; ++i) {
            const double x = node[i] >= 0 ? ss_table_number(table, i, column, l->error) : 0.0;
            if (isnan(x)) {
                return false;
            }
            if (node[i] >= 0 && fabs(x - mesh->position[node[i]][k]) > far) {
                softsim_error_add(l->error, SOFTSIM_ERROR_FORMAT,
                                  "%s:%d: %s is %.9g, in the mesh it is %.9g: the table is of "
                                  "another mesh",
                                  table->path, table->line[i], axes[k], x,
                                  mesh->position[node[i]][k]);
                return false;
            }
        }
    }
    return true;
}

static bool read_weights(loader *l, const ss_table *table, const int32_t *node)
{
    ss_case_body *b = l->body;
    const int32_t column = ss_table_find(table, "w", l->error);
    b->weight = calloc((size_t)b->mesh->node_count, sizeof *b->weight);
    if (b->weight == NULL) {
        no_memory(l);
        return false;
    }
    for (int32_t i = 0; i < table->row_count && column >= 0; ++i) {
        if (node[i] >= 0) {
            b->weight[node[i]] = ss_table_number(table, i, column, l->error);
            if (isnan(b->weight[node[i]])) {
                return false;
            }
            if (b->weight[node[i]] < 0.0) {
                softsim_error_add(l->error, SOFTSIM_ERROR_FORMAT, "%s:%d: a weight below 0",
                                  table->path, table->line[i]);
                return false;
            }
        }
    }
    return column >= 0;
}

static void read_reference(loader *l, int32_t material)
{
    const char *name = l->mesh->reference[material];
    char path[LONG_PATH];
    ss_table table = {.path = NULL};
    if (name[0] == '\0') {
        softsim_error_add(l->error, SOFTSIM_ERROR_FORMAT,
                          "%s/case.yaml: mesh '%s' has no reference for '%s'", l->c->folder,
                          l->mesh->name, l->c->material[material]);
        return;
    }
    join(l, name, path);
    bool is_good = ss_table_load(path, &table, l->error) == SOFTSIM_OK;
    int32_t *node = calloc((size_t)table.row_count + 1, sizeof *node);
    if (node == NULL) {
        no_memory(l);
    }
    is_good = is_good && node != NULL && match_rows(l, &table, node) &&
              check_positions(l, &table, node) &&
              (l->body->weight != NULL || read_weights(l, &table, node));
    for (int32_t i = 0; i < l->c->level_count && is_good; ++i) {
        is_good = l->c->level[i].material != material || read_level(l, &table, node, i);
    }
    free(node);
    ss_table_fini(&table);
}

softsim_status ss_case_load_body(const ss_case *c, const ss_case_mesh *mesh, int32_t material,
                                 bool on_surface, ss_case_body *out, softsim_error *error)
{
    const int32_t faults = error->fault_count;
    loader l = {.c = c, .mesh = mesh, .body = out, .error = error};
    *out = (ss_case_body){.level_count = c->level_count};
    out->reference = calloc((size_t)c->level_count + 1, sizeof *out->reference);
    if (out->reference == NULL) {
        no_memory(&l);
    } else if (!ss_case_has_body(mesh, on_surface)) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s/case.yaml: mesh '%s' has no %s file",
                          c->folder, mesh->name, on_surface ? "surface" : "volume");
    } else if (on_surface ? load_surface(&l) : load_volume(&l)) {
        read_sets(&l, on_surface);
        if (material >= 0 && error->fault_count == faults) {
            read_reference(&l, material);
        }
    }
    free(l.sorted);
    return error->fault_count > faults ? error->status : SOFTSIM_OK;
}

void ss_case_body_fini(ss_case_body *body)
{
    for (int32_t i = 0; i < body->level_count && body->reference != NULL; ++i) {
        free(body->reference[i]);
    }
    SS_EACH(free, body->reference, body->number, body->weight, body->fixed, body->pushed,
            body->profile, body->pressed);
    ss_mesh_destroy(&body->mesh);
    *body = (ss_case_body){.mesh = NULL};
}
