/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Loads and prescribed displacements: regions of the scene become sets of nodes. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/loader.h"

/* Nodes in all sets of loads and prescribed displacements together; bounds the memory that a
 * small file with many regions on a large mesh can ask for. */
enum { MAX_SET_NODES = 4000000 };

/* The numbers of the nodes in the mask, increasing; NULL when there is no room for them. */
static int32_t *list_nodes(ss_scene_loader *l, const uint8_t *mask, uint8_t value, int32_t count)
{
    l->set_nodes += count;
    if (l->set_nodes > MAX_SET_NODES) {
        ss_scene_report_add(l->report, SOFTSIM_ERROR_SCENE, (ss_scene_place){-1, 0, 0},
                            "loads and prescribed sets hold more than %d nodes together",
                            MAX_SET_NODES);
        return NULL;
    }
    int32_t *list = calloc((size_t)count + 1, sizeof *list);
    if (list == NULL) {
        ss_scene_fault_memory(l);
        return NULL;
    }
    int32_t used = 0;
    for (int32_t i = 0; i < l->scene->mesh->node_count && used < count; i++) {
        if (mask[i] == value) {
            list[used++] = i;
        }
    }
    return list;
}

static bool has_triangle(const ss_mesh *mesh, const uint8_t *mask)
{
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        const int32_t *node = mesh->triangle[t];
        if (mask[node[0]] && mask[node[1]] && mask[node[2]]) {
            return true;
        }
    }
    return false;
}

static void take_load(ss_scene_loader *l, ss_scene_node *item)
{
    const int32_t count = ss_scene_select(&l->space, item);
    if (count < 0) {
        return;
    }
    ss_load load = {.from = ss_scene_get_number(item, "from_s", 0),
                    .to = ss_scene_get_number(item, "to_s", INFINITY),
                    .ramp = ss_scene_get_number(item, "ramp_s", 0),
                    .pressure = ss_scene_get_number(item, "pressure_pa", 0),
                    .is_pressure = ss_scene_node_find(item, "pressure_pa") != NULL};
    ss_scene_get_vector(ss_scene_node_find(item, "force_n"), load.force);
    if (load.to <= load.from) {
        ss_scene_node_fault(l->report, ss_scene_node_find(item, "to_s"),
                            "the load ends at %g s, before it begins at %g s; give a later to_s",
                            load.to, load.from);
        return;
    }
    if (load.is_pressure && !has_triangle(l->scene->mesh, l->space.mask)) {
        ss_scene_key_fault(l->report, ss_scene_node_find(item, "pressure_pa"),
                           "no triangle of the surface has all its nodes in the region, so the "
                           "pressure acts on nothing; enlarge the region");
        return;
    }
    load.node = list_nodes(l, l->space.mask, 1, count);
    load.node_count = count;
    if (load.node != NULL) {
        l->scene->load[l->scene->load_count++] = load;
    }
}

void ss_scene_take_loads(ss_scene_loader *l)
{
    ss_scene_node *list = ss_scene_node_find(l->root, "loads");
    const int32_t count = ss_scene_entry_count(list);
    l->scene->load = calloc((size_t)count + 1, sizeof *l->scene->load);
    if (l->scene->load == NULL) {
        ss_scene_fault_memory(l);
        return;
    }
    for (ss_scene_node *item = count > 0 ? list->first : NULL; item != NULL; item = item->next) {
        if (!item->is_faulty) {
            take_load(l, item);
        }
    }
}

static bool has_region(const ss_scene_node *item)
{
    for (const ss_scene_node *key = item->first; key != NULL; key = key->next) {
        if (ss_scene_find_row(ss_scene_where, key->key) != NULL) {
            return true;
        }
    }
    return false;
}

/* Into space->mask: per node the axes that are held, as bits; into `u` where to. */
static bool read_prescribed(ss_scene_loader *l, ss_scene_node *item, double (*u)[3])
{
    const int32_t node_count = l->scene->mesh->node_count;
    uint8_t *mask = l->space.mask;
    const uint8_t axes = ss_scene_axes_of(item);
    ss_scene_node *file = ss_scene_node_find(item, "displacement_file");
    double uniform[3] = {0, 0, 0};
    ss_scene_get_vector(ss_scene_node_find(item, "displacement_m"), uniform);
    if (file == NULL && !has_region(item)) {
        ss_scene_node_fault(l->report, item,
                            "displacement_m needs nodes; give one of: box_m, sphere, plane, group, "
                            "nodes");
        return false;
    }
    if (has_region(item) && ss_scene_select(&l->space, item) < 0) {
        return false;
    }
    if (file == NULL) {
        for (int32_t i = 0; i < node_count; i++) {
            memcpy(u[i], uniform, sizeof uniform);
            mask[i] = mask[i] ? axes : 0;
        }
        return true;
    }
    /* A region beside a file is a promise about the file's nodes, and is held to. */
    uint8_t *region = has_region(item) ? malloc((size_t)node_count) : NULL;
    if (region != NULL) {
        memcpy(region, mask, (size_t)node_count);
    }
    bool is_good = ss_scene_read_displacement(&l->space, file, u) >= 0;
    for (int32_t i = 0; i < node_count && is_good; i++) {
        if (mask[i] && region != NULL && !region[i]) {
            ss_scene_node_fault(l->report, file,
                                "'%.100s' names node %d, which is not in the region beside it",
                                file->text, (int)i);
            is_good = false;
        }
        uint8_t held = 0;
        for (int k = 0; k < 3 && mask[i]; k++) {
            held = (uint8_t)(held | (isnan(u[i][k]) ? 0u : axes & (1u << k)));
        }
        mask[i] = held;
    }
    free(region);
    return is_good;
}

/* One node held twice along one axis has no meaning: named, once per entry. */
static bool is_conflicting(ss_scene_loader *l, ss_scene_node *item, uint8_t *held)
{
    for (int32_t i = 0; i < l->scene->mesh->node_count; i++) {
        const uint8_t both = held[i] & l->space.mask[i];
        if (both != 0) {
            char path[256];
            ss_scene_node_path(item, path, sizeof path);
            ss_scene_node_fault(l->report, item,
                                "%s holds node %d along %c, which is %s already; leave it to one",
                                path, (int)i,
                                both & 1   ? 'x'
                                : both & 2 ? 'y'
                                           : 'z',
                                l->scene->fixed[i] & both ? "fixed" : "prescribed");
            return true;
        }
    }
    for (int32_t i = 0; i < l->scene->mesh->node_count; i++) {
        held[i] |= l->space.mask[i];
    }
    return false;
}

/* One set for each pattern of held axes that occurs. */
static void add_prescribed(ss_scene_loader *l, ss_scene_node *item, const double (*u)[3])
{
    ss_scene *scene = l->scene;
    const ss_scene_node *group = ss_scene_node_find(item, "group");
    for (uint8_t bits = 1; bits < 8; bits++) {
        int32_t count = 0;
        for (int32_t i = 0; i < scene->mesh->node_count; i++) {
            count += l->space.mask[i] == bits;
        }
        if (count == 0) {
            continue;
        }
        ss_scene_prescribed set = {.node_count = count,
                                   .axis = {bits & 1, bits & 2, bits & 4},
                                   .from = ss_scene_get_number(item, "from_s", 0),
                                   .ramp = ss_scene_get_number(item, "ramp_s", 0),
                                   .entry = item->index};
        if (group != NULL) {
            snprintf(set.name, sizeof set.name, "%.60s", group->text);
        } else {
            snprintf(set.name, sizeof set.name, "prescribed.%d", (int)item->index);
        }
        set.node = list_nodes(l, l->space.mask, bits, count);
        set.displacement = calloc((size_t)count, sizeof *set.displacement);
        if (set.node == NULL || set.displacement == NULL) {
            free(set.node);
            free(set.displacement);
            ss_scene_fault_memory(l);
            return;
        }
        for (int32_t i = 0; i < count; i++) {
            for (int k = 0; k < 3; k++) {
                set.displacement[i][k] = set.axis[k] ? u[set.node[i]][k] : 0;
            }
        }
        scene->prescribed[scene->prescribed_count++] = set;
    }
}

void ss_scene_take_prescribed(ss_scene_loader *l)
{
    ss_scene_node *list = ss_scene_node_find(l->root, "prescribed");
    const int32_t count = ss_scene_entry_count(list);
    const size_t node_count = (size_t)l->scene->mesh->node_count;
    l->scene->prescribed = calloc(7 * (size_t)count + 1, sizeof *l->scene->prescribed);
    uint8_t *held = malloc(node_count);
    double(*u)[3] = count > 0 ? calloc(node_count, sizeof *u) : NULL;
    if (l->scene->prescribed == NULL || held == NULL || (count > 0 && u == NULL)) {
        ss_scene_fault_memory(l);
    } else {
        memcpy(held, l->scene->fixed, node_count);
        for (ss_scene_node *item = count > 0 ? list->first : NULL; item != NULL;
             item = item->next) {
            if (!item->is_faulty && read_prescribed(l, item, u) && !is_conflicting(l, item, held)) {
                add_prescribed(l, item, (const double(*)[3])u);
            }
        }
    }
    free(held);
    free(u);
}
