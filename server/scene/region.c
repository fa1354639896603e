/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Regions and data files on the mesh. */
#include "scene/region.h"

#include "rt/csv.h"
#include "rt/files.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_DATA_BYTES = 256 << 20, /* of one data file: four million rows of the longest kind */
    MAX_FILE_FAULTS = 3,        /* shown per data file: one wrong column spoils every row */
    MAX_CELLS = 4
};

/* ---- data files ---- */

bool ss_scene_join_path(const char *folder, const char *path, char *out, size_t size)
{
    const int length = snprintf(out, size, "%s%s", path[0] == '/' ? "" : folder, path);
    return length > 0 && (size_t)length < size;
}

typedef struct data_file {
    ss_scene_space *space;
    ss_scene_node *node; /* that names it */
    char *text;
    char *next;
    int64_t line;
    int32_t faults;
} data_file;

static void fault_line(data_file *file, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
static void fault_line(data_file *file, const char *format, ...)
{
    char text[320];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (ss_scene_node *node = file->node; node != NULL; node = node->parent) {
        node->is_faulty = true;
    }
    if (file->faults++ < MAX_FILE_FAULTS) {
        ss_scene_report_file(file->space->report, ss_scene_node_place(file->node), file->node->text,
                             file->line, "%s", text);
    }
}

/* The whole of a regular file, with a NUL behind it; NULL with *out_why set. */
static char *read_whole(const char *path, const char **out_why)
{
    int64_t size = 0;
    FILE *stream = ss_files_open_stream(path, &size, out_why);
    if (stream == NULL) {
        return NULL;
    }
    char *text = NULL;
    if (size > MAX_DATA_BYTES) {
        *out_why = "larger than 256 MB";
    } else if ((text = malloc((size_t)size + 1)) == NULL) {
        *out_why = "out of memory";
    } else {
        const size_t got = fread(text, 1, (size_t)size, stream);
        text[got] = '\0';
        if (ferror(stream) || memchr(text, '\0', got) != NULL) {
            *out_why = ferror(stream) ? "cannot be read" : "it has a NUL byte, so it is not a text";
            free(text);
            text = NULL;
        }
    }
    fclose(stream);
    return text;
}

static bool open_data(data_file *file, ss_scene_space *space, ss_scene_node *node)
{
    char path[2048];
    const char *why = "the path is too long";
    *file = (data_file){.space = space, .node = node};
    if (ss_scene_join_path(space->folder, node->text, path, sizeof path)) {
        file->text = read_whole(path, &why);
    }
    if (file->text == NULL) {
        ss_scene_node_fault(space->report, node, "cannot open '%.200s': %s", node->text, why);
        return false;
    }
    file->next = file->text;
    if (strncmp(file->next, SS_CSV_MARK, strlen(SS_CSV_MARK)) == 0) {
        file->next += strlen(SS_CSV_MARK);
    }
    return true;
}

/* The next line that is neither blank nor a comment; NULL at the end. */
static char *next_line(data_file *file)
{
    char *line = NULL;
    while (line == NULL && *file->next != '\0') {
        char *start = file->next;
        char *end = strchrnul(start, '\n');
        file->next = *end == '\n' ? end + 1 : end;
        file->line += 1;
        *end = '\0';
        line = ss_csv_trim(start);
    }
    return line;
}

static void close_data(data_file *file)
{
    free(file->text);
    file->text = NULL;
}

/* The number of a node or element (`what`) below `count` in a data file; -1 after a fault. Marks it
 * in `mask`: twice is a fault. */
static int32_t take_number(data_file *file, const char *text, const char *what, int32_t count,
                           uint8_t *mask)
{
    double value = 0;
    if (ss_scene_parse_number(text, &value) != SS_SCENE_GOOD || value != floor(value)) {
        fault_line(file, "'%.40s' is not %s number", text,
                   what[0] == 'e' ? "an element" : "a node");
        return -1;
    }
    if (value < 0 || value >= count) {
        fault_line(file, "there is no %s %.40s; the mesh has %ss 0 to %d", what, text, what,
                   (int)count - 1);
        return -1;
    }
    const int32_t number = (int32_t)value;
    if (mask[number]) {
        fault_line(file, "%s %d is given twice; remove one", what, (int)number);
        return -1;
    }
    mask[number] = 1;
    return number;
}

static int32_t take_node(data_file *file, const char *text)
{
    return take_number(file, text, "node", file->space->mesh->node_count, file->space->mask);
}

/* The header line must be the one that names the columns. */
static bool take_header(data_file *file, const char *expected)
{
    char *line = next_line(file);
    if (line == NULL || strcmp(line, expected) != 0) {
        fault_line(file, "the first line is '%.60s'; it must be %s", line != NULL ? line : "",
                   expected);
        return false;
    }
    return true;
}

/* ---- regions ---- */

static void select_listed(ss_scene_space *space, ss_scene_node *list)
{
    const int32_t node_count = space->mesh->node_count;
    int32_t faults = 0;
    for (ss_scene_node *item = list->first; item != NULL && faults < MAX_FILE_FAULTS;
         item = item->next) {
        double value = -1;
        ss_scene_parse_number(item->text, &value);
        if (value < 0 || value >= node_count) {
            ss_scene_node_fault(space->report, item,
                                "there is no node %.40s; the mesh has nodes 0 to %d", item->text,
                                (int)node_count - 1);
            faults++;
        } else if (space->mask[(int32_t)value]) {
            ss_scene_node_fault(space->report, item, "node %.40s is given twice; remove one",
                                item->text);
            faults++;
        } else {
            space->mask[(int32_t)value] = 1;
        }
    }
}

static void select_file(ss_scene_space *space, ss_scene_node *node)
{
    data_file file;
    if (!open_data(&file, space, node)) {
        return;
    }
    for (char *line = next_line(&file); line != NULL && file.faults < MAX_FILE_FAULTS;
         line = next_line(&file)) {
        take_node(&file, line);
    }
    close_data(&file);
}

static void select_group(ss_scene_space *space, ss_scene_node *node)
{
    const ss_mesh *mesh = space->mesh;
    char names[200] = "";
    for (int32_t i = 0; i < mesh->group_count; i++) {
        const ss_mesh_group *group = &mesh->group[i];
        if (strcmp(group->name, node->text) == 0) {
            for (int32_t k = 0; k < group->node_count; k++) {
                space->mask[group->node[k]] = 1;
            }
            return;
        }
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", used > 0 ? ", " : "", group->name);
    }
    ss_scene_node_fault(space->report, node, "the mesh has no group '%.60s'; it has: %s",
                        node->text, names[0] != '\0' ? names : "none");
}

static void select_box(ss_scene_space *space, const ss_scene_node *box)
{
    double low[3] = {0};
    double high[3] = {0};
    ss_scene_get_vector(box->first, low);
    ss_scene_get_vector(box->last, high);
    for (int32_t i = 0; i < space->mesh->node_count; i++) {
        const double *x = space->mesh->position[i];
        bool is_inside = true;
        for (int k = 0; k < 3; k++) {
            is_inside = is_inside && x[k] >= low[k] - space->tolerance &&
                        x[k] <= high[k] + space->tolerance;
        }
        space->mask[i] = is_inside;
    }
}

static void select_sphere(ss_scene_space *space, const ss_scene_node *sphere)
{
    double center[3] = {0};
    ss_scene_get_vector(ss_scene_node_find(sphere, "center_m"), center);
    const double radius = ss_scene_get_number(sphere, "radius_m", 0) + space->tolerance;
    for (int32_t i = 0; i < space->mesh->node_count; i++) {
        const double *x = space->mesh->position[i];
        const double d[3] = {x[0] - center[0], x[1] - center[1], x[2] - center[2]};
        space->mask[i] = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= radius * radius;
    }
}

/* Behind the plane: (x - p) . n <= 0. */
static void select_plane(ss_scene_space *space, ss_scene_node *plane)
{
    double point[3] = {0};
    double normal[3] = {0};
    ss_scene_node *normal_node = ss_scene_node_find(plane, "normal");
    ss_scene_get_vector(ss_scene_node_find(plane, "point_m"), point);
    ss_scene_get_vector(normal_node, normal);
    const double length =
        sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    if (!(length > 0)) {
        ss_scene_node_fault(space->report, normal_node, "the normal has no length");
        return;
    }
    for (int32_t i = 0; i < space->mesh->node_count; i++) {
        const double *x = space->mesh->position[i];
        double distance = 0;
        for (int k = 0; k < 3; k++) {
            distance += (x[k] - point[k]) * normal[k] / length;
        }
        space->mask[i] = distance <= space->tolerance;
    }
}

static int32_t count_mask(const ss_scene_space *space)
{
    int32_t count = 0;
    for (int32_t i = 0; i < space->mesh->node_count; i++) {
        count += space->mask[i] != 0;
    }
    return count;
}

int32_t ss_scene_select(ss_scene_space *space, ss_scene_node *map)
{
    memset(space->mask, 0, (size_t)space->mesh->node_count);
    ss_scene_node *region = NULL;
    if ((region = ss_scene_node_find(map, "box_m")) != NULL) {
        select_box(space, region);
    } else if ((region = ss_scene_node_find(map, "sphere")) != NULL) {
        select_sphere(space, region);
    } else if ((region = ss_scene_node_find(map, "plane")) != NULL) {
        select_plane(space, region);
    } else if ((region = ss_scene_node_find(map, "group")) != NULL) {
        select_group(space, region);
    } else if ((region = ss_scene_node_find(map, "nodes")) != NULL) {
        if (region->kind == SS_SCENE_LIST) {
            select_listed(space, region);
        } else {
            select_file(space, region);
        }
    }
    if (region == NULL || region->is_faulty) {
        return -1;
    }
    const int32_t count = count_mask(space);
    if (count == 0) {
        char path[256];
        const ss_scene_row *row = ss_scene_find_row(ss_scene_where, region->key);
        ss_scene_node_path(region, path, sizeof path);
        ss_scene_key_fault(space->report, region, "%s takes no node of the mesh; %s", path,
                           row != NULL && row->kind == SS_SCENE_NODES
                               ? "the file names none"
                               : "regions are in metres on the transformed mesh "
                                 "(softsim-mesh info prints its box)");
        return -1;
    }
    return count;
}

/* ---- the nodes of a grid ---- */

bool ss_scene_read_points(ss_scene_space *space, ss_scene_node *node, double metres, int32_t count,
                          double (*out_position)[3])
{
    data_file file;
    if (!open_data(&file, space, node)) {
        return false;
    }
    int32_t used = 0;
    char *line = take_header(&file, "x,y,z") ? next_line(&file) : NULL;
    for (; line != NULL && file.faults < MAX_FILE_FAULTS; line = next_line(&file)) {
        char *cell[MAX_CELLS];
        double x[3] = {0, 0, 0};
        bool is_good = ss_csv_split(line, cell, MAX_CELLS) == 3;
        for (int k = 0; k < 3 && is_good; k++) {
            is_good = ss_scene_parse_number(cell[k], &x[k]) == SS_SCENE_GOOD;
        }
        if (!is_good) {
            fault_line(&file, "not a point; each row is x,y,z: three finite numbers");
        } else if (used == count) {
            fault_line(&file, "more points than the grid has: rows times columns is %d",
                       (int)count);
            break;
        } else {
            for (int k = 0; k < 3; k++) {
                out_position[used][k] = metres * x[k];
            }
            used++;
        }
    }
    if (file.faults == 0 && used < count) {
        fault_line(&file, "the file ends after %d points; rows times columns is %d", (int)used,
                   (int)count);
    }
    const bool is_good = file.faults == 0;
    close_data(&file);
    return is_good;
}

/* ---- values per node ---- */

/* A fault for nodes or elements (`what`) without a value, if there are any. */
static bool has_all(ss_scene_space *space, ss_scene_node *node, const char *what, int32_t count,
                    const uint8_t *has)
{
    int32_t missing = 0;
    int32_t first = -1;
    for (int32_t i = 0; i < count; i++) {
        if (!has[i]) {
            first = first < 0 ? i : first;
            missing++;
        }
    }
    if (missing > 0) {
        char path[256];
        ss_scene_node_path(node, path, sizeof path);
        ss_scene_node_fault(space->report, node, "%s gives no value to %d %ss, the first is %d; %s",
                            path, (int)missing, what, (int)first,
                            node->kind == SS_SCENE_LIST ? "end the list with {value: ...}"
                                                        : "give every one a row");
    }
    return missing == 0;
}

/* A value of `row`'s field in a data file; false after a fault. */
static bool take_value(data_file *file, const ss_scene_row *row, const char *text, double *out)
{
    char why[96];
    if (ss_scene_read_scalar(row, text, false, out, why, sizeof why)) {
        return true;
    }
    char expected[200];
    ss_scene_row one = *row;
    one.kind = SS_SCENE_NUMBER;
    ss_scene_describe(&one, expected, sizeof expected);
    fault_line(file, "the value %s; give %s", why, expected);
    return false;
}

/* The first line is one of the two headers; with the second, *out_is_element. */
static bool take_field_header(data_file *file, const ss_scene_row *row, bool *out_is_element)
{
    if (!row->takes_elements) {
        return take_header(file, "node,value");
    }
    const char *line = next_line(file);
    *out_is_element = line != NULL && strcmp(line, "element,value") == 0;
    if (!*out_is_element && (line == NULL || strcmp(line, "node,value") != 0)) {
        fault_line(file, "the first line is '%.60s'; it must be node,value or element,value",
                   line != NULL ? line : "");
        return false;
    }
    return true;
}

/* The rows below the header, one of each of `count` nodes or elements (`what`). */
static bool read_field_rows(ss_scene_space *space, const ss_scene_row *row, ss_scene_node *name,
                            data_file *file, const char *what, int32_t count, double *out_value)
{
    uint8_t *has = calloc((size_t)count, 1);
    if (has == NULL) {
        ss_scene_node_fault(space->report, name, "out of memory");
        return false;
    }
    char *line = next_line(file);
    for (; line != NULL && file->faults < MAX_FILE_FAULTS; line = next_line(file)) {
        char *cell[MAX_CELLS];
        if (ss_csv_split(line, cell, MAX_CELLS) != 2) {
            fault_line(file, "not two cells; each row is %s,value", what);
            continue;
        }
        const int32_t i = take_number(file, cell[0], what, count, has);
        double value = 0;
        if (take_value(file, row, cell[1], &value) && i >= 0) {
            out_value[i] = value;
        }
    }
    const bool is_whole = file->faults == 0 && has_all(space, name, what, count, has);
    free(has);
    return is_whole;
}

static bool read_field_file(ss_scene_space *space, const ss_scene_row *row, ss_scene_node *node,
                            double *out_value, double *out_element, bool *out_is_element)
{
    data_file file;
    ss_scene_node *name = ss_scene_node_find(node, "file");
    if (!open_data(&file, space, name)) {
        return false;
    }
    bool is_good = take_field_header(&file, row, out_is_element);
    if (is_good && *out_is_element) {
        is_good = read_field_rows(space, row, name, &file, "element",
                                  ss_mesh_element_count(space->mesh), out_element);
    } else if (is_good) {
        is_good =
            read_field_rows(space, row, name, &file, "node", space->mesh->node_count, out_value);
    }
    close_data(&file);
    return is_good;
}

/* Rows node,node,value after the header: how many, into *out_link with room for all of them. */
static int32_t read_link_rows(data_file *file, const ss_scene_row *row, ss_param_link *out_link)
{
    uint8_t *mask = file->space->mask;
    int32_t count = 0;
    for (char *line = next_line(file); line != NULL && file->faults < MAX_FILE_FAULTS;
         line = next_line(file)) {
        char *cell[MAX_CELLS];
        if (ss_csv_split(line, cell, MAX_CELLS) != 3) {
            fault_line(file, "not three cells; each row is node,node,value");
            continue;
        }
        ss_param_link link = {{-1, -1}, 0.0};
        for (int k = 0; k < 2; k++) {
            link.node[k] = take_node(file, cell[k]); /* the same twice is a fault */
        }
        for (int k = 0; k < 2; k++) {
            if (link.node[k] >= 0) {
                mask[link.node[k]] = 0;
            }
        }
        if (take_value(file, row, cell[2], &link.value) && link.node[0] >= 0 && link.node[1] >= 0) {
            out_link[count++] = link;
        }
    }
    return count;
}

int32_t ss_scene_read_links(ss_scene_space *space, const ss_scene_row *row, ss_scene_node *node,
                            ss_param_link **out_link)
{
    data_file file;
    ss_scene_node *name = node->kind == SS_SCENE_MAP ? ss_scene_node_find(node, "file") : NULL;
    *out_link = NULL;
    if (!row->takes_links || name == NULL) {
        return 0;
    }
    if (!open_data(&file, space, name)) {
        return -1;
    }
    const char *header = next_line(&file);
    int32_t count = 0;
    if (header != NULL && strcmp(header, "node,node,value") == 0) {
        size_t lines = 1;
        for (const char *at = file.next; *at != '\0'; at++) {
            lines += *at == '\n';
        }
        memset(space->mask, 0, (size_t)space->mesh->node_count);
        *out_link = calloc(lines, sizeof **out_link);
        if (*out_link == NULL) {
            ss_scene_node_fault(space->report, name, "out of memory");
        } else {
            count = read_link_rows(&file, row, *out_link);
        }
        if (file.faults == 0 && *out_link != NULL && count == 0) {
            fault_line(&file, "no link is named");
        }
        count = file.faults == 0 && *out_link != NULL ? count : -1;
    }
    close_data(&file);
    return count;
}

/* Notes that an entry takes `selected` nodes, `taken` of which no earlier one did. */
static void note_overlap(ss_scene_space *space, const ss_scene_node *item, int32_t selected,
                         int32_t taken)
{
    ss_scene *scene = space->scene;
    if (scene->doubt_count == SS_SCENE_MAX_DOUBTS) {
        return;
    }
    ss_scene_doubt *doubt = &scene->doubt[scene->doubt_count++];
    doubt->is_unused = taken == 0;
    ss_scene_node_path(item, doubt->where, sizeof doubt->where);
    if (taken == 0) {
        snprintf(doubt->text, sizeof doubt->text,
                 "no node has this value: earlier entries took all %d that it names, and the first "
                 "that matches counts; put it before them, or leave it out",
                 (int)selected);
    } else {
        snprintf(doubt->text, sizeof doubt->text,
                 "%d of its %d nodes have the value of an earlier entry: the first that matches "
                 "counts",
                 (int)(selected - taken), (int)selected);
    }
}

/* First match wins. */
static bool read_field_regions(ss_scene_space *space, ss_scene_node *list, double *out_value)
{
    const int32_t node_count = space->mesh->node_count;
    uint8_t *has = calloc((size_t)node_count, 1);
    if (has == NULL) {
        ss_scene_node_fault(space->report, list, "out of memory");
        return false;
    }
    bool is_good = true;
    for (ss_scene_node *item = list->first; item != NULL; item = item->next) {
        ss_scene_node *where = ss_scene_node_find(item, "where");
        const double value = ss_scene_get_number(item, "value", 0);
        if (where == NULL) {
            memset(space->mask, 1, (size_t)node_count);
        } else if (ss_scene_select(space, where) < 0) {
            is_good = false;
            continue;
        }
        int32_t selected = 0, taken = 0;
        for (int32_t i = 0; i < node_count; i++) {
            selected += space->mask[i] != 0;
            if (space->mask[i] && !has[i]) {
                out_value[i] = value;
                has[i] = 1;
                ++taken;
            }
        }
        if (taken == 0 || (taken < selected && where != NULL)) {
            note_overlap(space, item, selected, taken);
        }
    }
    is_good = is_good && has_all(space, list, "node", node_count, has);
    free(has);
    return is_good;
}

bool ss_scene_read_field(ss_scene_space *space, const ss_scene_row *row, ss_scene_node *node,
                         double *out_value, double *out_element, bool *out_is_element)
{
    *out_is_element = false;
    return node->kind == SS_SCENE_MAP
               ? read_field_file(space, row, node, out_value, out_element, out_is_element)
               : read_field_regions(space, node, out_value);
}

bool ss_scene_read_directions(ss_scene_space *space, ss_scene_node *node,
                              double (*out_direction)[3])
{
    data_file file;
    ss_scene_node *name = ss_scene_node_find(node, "file");
    const int32_t count = ss_mesh_element_count(space->mesh);
    uint8_t *has = calloc((size_t)count, 1);
    if (has == NULL) {
        ss_scene_node_fault(space->report, name, "out of memory");
        return false;
    }
    if (!open_data(&file, space, name)) {
        free(has);
        return false;
    }
    char *line = take_header(&file, "element,x,y,z") ? next_line(&file) : NULL;
    for (; line != NULL && file.faults < MAX_FILE_FAULTS; line = next_line(&file)) {
        char *cell[MAX_CELLS];
        double v[3] = {0, 0, 0};
        if (ss_csv_split(line, cell, MAX_CELLS) != 4) {
            fault_line(&file, "not four cells; each row is element,x,y,z");
            continue;
        }
        const int32_t e = take_number(&file, cell[0], "element", count, has);
        bool is_good = e >= 0;
        for (int k = 0; k < 3 && is_good; k++) {
            is_good = ss_scene_parse_number(cell[k + 1], &v[k]) == SS_SCENE_GOOD;
            if (!is_good) {
                fault_line(&file, "'%.40s' is not a finite number", cell[k + 1]);
            }
        }
        if (is_good && !ss_scene_normalise(v)) {
            fault_line(&file, "the direction of element %d has no length", (int)e);
        } else if (is_good) {
            memcpy(out_direction[e], v, sizeof v);
        }
    }
    const bool is_good = file.faults == 0;
    close_data(&file);
    const bool is_whole = is_good && has_all(space, name, "element", count, has);
    free(has);
    return is_whole;
}

int32_t ss_scene_read_displacement(ss_scene_space *space, ss_scene_node *node,
                                   double (*out_displacement)[3])
{
    data_file file;
    memset(space->mask, 0, (size_t)space->mesh->node_count);
    if (!open_data(&file, space, node)) {
        return -1;
    }
    int32_t count = 0;
    char *line = take_header(&file, "node,ux,uy,uz") ? next_line(&file) : NULL;
    for (; line != NULL && file.faults < MAX_FILE_FAULTS; line = next_line(&file)) {
        char *cell[MAX_CELLS];
        if (ss_csv_split(line, cell, MAX_CELLS) != 4) {
            fault_line(&file, "not four cells; each row is node,ux,uy,uz");
            continue;
        }
        const int32_t i = take_node(&file, cell[0]);
        for (int k = 0; k < 3 && i >= 0; k++) {
            double value = NAN;
            if (cell[k + 1][0] != '\0' &&
                (ss_scene_parse_number(cell[k + 1], &value) != SS_SCENE_GOOD ||
                 fabs(value) > 1e4)) {
                fault_line(&file, "'%.40s' is not a displacement in m; give a number or nothing",
                           cell[k + 1]);
            }
            out_displacement[i][k] = value;
        }
        count++;
    }
    if (count == 0 && file.faults == 0) {
        fault_line(&file, "no rows");
    }
    const bool is_good = file.faults == 0;
    close_data(&file);
    return is_good ? count : -1;
}
