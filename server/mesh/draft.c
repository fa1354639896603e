/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Which elements are kept: with tetrahedra, and cells that are split into them (cells.h), only
 * those, and the surface is extracted from them; else triangles and quads. Quads beside triangles
 * are cut in two, at their place in the file's order. Everything else is counted in the mesh's
 * `skipped`.
 *
 * Groups grow by appending the nodes of their elements, so that each node comes many times. When a
 * group's list is full, a bit for each node gathers it into increasing order without repeats, and
 * only if it is then still more than half full it doubles: memory stays below four times the
 * nodes named, time below a small multiple of the appends. A bit for each node and group was
 * rejected (a thousand groups on a large mesh), and so was a table of groups by element, which
 * costs every mesh what only few need.
 */
#include "mesh/draft.h"

#include "mesh/cells.h"
#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/plain.h"
#include "rt/vec.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

ss_draft *ss_draft_create(ss_text *text, double metres_per_unit)
{
    ss_draft *d = ss_memory_get(1, sizeof *d);
    if (d == NULL) {
        (void)ss_text_out_of_memory(text);
        return NULL;
    }
    d->text = text;
    d->metres_per_unit = metres_per_unit;
    return d;
}

void ss_draft_destroy(ss_draft **draft)
{
    ss_draft *d = *draft;
    if (d == NULL) {
        return;
    }
    for (int32_t g = 0; g < d->group_count; ++g) {
        ss_memory_free(d->group[g].node);
    }
    SS_EACH(ss_memory_free, d->position, d->tag, d->triangle, d->quad, d->tetrahedron, d->middle,
            d->bits, d);
    *draft = NULL;
}

/* ---- nodes ---- */

bool ss_draft_make_nodes(ss_draft *d, int64_t count, bool has_tags)
{
    if (count > SS_DRAFT_MAX_COUNT) {
        ss_text_fault(d->text,
                      "%lld nodes announced, but more than 67 million are not read: "
                      "simplify the mesh first",
                      (long long)count);
        return false;
    }
    d->node_count = (int32_t)count;
    d->position = ss_memory_get((size_t)count, sizeof *d->position);
    d->tag = has_tags ? ss_memory_get((size_t)count, sizeof *d->tag) : NULL;
    return d->position != NULL && (d->tag != NULL || !has_tags) ? true
                                                                : ss_text_out_of_memory(d->text);
}

bool ss_draft_put_node(ss_draft *d, int32_t i, const double x[3])
{
    ss_scale3(d->position[i], x, d->metres_per_unit);
    if (!ss_mesh_is_place(d->position[i])) {
        ss_text_fault(d->text, "node %d: its position is not finite, or beyond 1e60: correct it",
                      i);
    }
    return d->text->fault_count < SS_TEXT_MAX_FAULTS;
}

static int compare_tags(const void *left, const void *right)
{
    const ss_draft_tag *a = left, *b = right;
    return ss_order_then(ss_order_int(a->tag, b->tag), ss_order_int(a->index, b->index));
}

bool ss_draft_sort_tags(ss_draft *d)
{
    bool is_sorted = true;
    for (int32_t i = 1; i < d->node_count && is_sorted; ++i) {
        is_sorted = d->tag[i].tag > d->tag[i - 1].tag;
    }
    if (is_sorted) {
        return true;
    }
    qsort(d->tag, (size_t)d->node_count, sizeof *d->tag, compare_tags);
    for (int32_t i = 1; i < d->node_count && d->text->fault_count < SS_TEXT_MAX_FAULTS; ++i) {
        if (d->tag[i].tag == d->tag[i - 1].tag) {
            d->text->line = d->tag[i].line;
            ss_text_fault(d->text, "node number %lld is on line %d already: number nodes uniquely",
                          (long long)d->tag[i].tag, d->tag[i - 1].line);
        }
    }
    return d->text->fault_count == 0;
}

int32_t ss_draft_find_node(const ss_draft *d, int64_t tag)
{
    if (d->node_count == 0 || tag < d->tag[0].tag) {
        return -1;
    }
    /* Files numbered without gaps need no search. */
    const int64_t guess = tag - d->tag[0].tag;
    if (guess < d->node_count && d->tag[guess].tag == tag) {
        return d->tag[guess].index;
    }
    int32_t low = 0;
    int32_t high = d->node_count;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (d->tag[middle].tag < tag) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < d->node_count && d->tag[low].tag == tag ? d->tag[low].index : -1;
}

/* ---- elements ---- */

int ss_draft_nodes(ss_mesh_kind kind)
{
    static const int8_t count[SS_MESH_KIND_COUNT] = {
        [SS_MESH_POINT] = 1,       [SS_MESH_LINE] = 2,           [SS_MESH_LINE_2] = 3,
        [SS_MESH_TRIANGLE] = 3,    [SS_MESH_TRIANGLE_2] = 6,     [SS_MESH_QUAD] = 4,
        [SS_MESH_TETRAHEDRON] = 4, [SS_MESH_TETRAHEDRON_2] = 10, [SS_MESH_HEXAHEDRON] = 8,
        [SS_MESH_PRISM] = 6,       [SS_MESH_PYRAMID] = 5};
    return count[kind];
}

bool ss_draft_makes_mesh(ss_mesh_kind kind)
{
    return kind == SS_MESH_TRIANGLE || kind == SS_MESH_QUAD || ss_draft_is_volume(kind);
}

bool ss_draft_is_volume(ss_mesh_kind kind)
{
    return kind >= SS_MESH_TETRAHEDRON && kind <= SS_MESH_PYRAMID;
}

/* "12 lines and 3 points" of what was found; empty when nothing was. */
static void list_found(const ss_draft *d, char *out, size_t size)
{
    size_t used = 0;
    out[0] = '\0';
    for (int kind = SS_MESH_KIND_COUNT - 1; kind >= SS_MESH_POINT; --kind) {
        if (d->found[kind] > 0 && used < size) {
            const long long count = (long long)d->found[kind];
            used += (size_t)snprintf(out + used, size - used, "%s%lld %s", used > 0 ? " and " : "",
                                     count, ss_mesh_kind_name((ss_mesh_kind)kind));
        }
    }
}

static void fault_no_elements(ss_draft *d, const char *other)
{
    char found[256];
    bool is_thin = true;
    list_found(d, found, sizeof found);
    for (int kind = SS_MESH_LINE_2 + 1; kind < SS_MESH_KIND_COUNT; ++kind) {
        is_thin = is_thin && d->found[kind] == 0;
    }
    if (is_thin) {
        ss_text_fault_file(
            d->text, SOFTSIM_ERROR_FORMAT,
            "it holds %s%sno triangle, quad or cell of a volume, so there is no body "
            "in it: mesh its surface or its volume",
            found, found[0] != '\0' ? " and " : "");
        return;
    }
    ss_text_fault_file(d->text, SOFTSIM_ERROR_FORMAT,
                       "it holds %s and nothing that makes a body%s%s: write triangles, quads, "
                       "tetrahedra, hexahedra, prisms or pyramids of first order, or tetrahedra of "
                       "second order",
                       found, other != NULL ? ", " : "", other != NULL ? other : "");
}

static bool fault_too_many(ss_draft *d)
{
    ss_text_fault_file(d->text, SOFTSIM_ERROR_FORMAT,
                       "more than 67 million elements are not read: simplify the mesh first");
    return false;
}

bool ss_draft_make_elements(ss_draft *d, const char *other)
{
    const int64_t triangles = d->found[SS_MESH_TRIANGLE];
    const int64_t quads = d->found[SS_MESH_QUAD];
    const int64_t second = d->found[SS_MESH_TETRAHEDRON_2];
    int64_t tetrahedra = d->found[SS_MESH_TETRAHEDRON] + second;
    int64_t first = d->found[SS_MESH_TETRAHEDRON];
    for (int kind = SS_MESH_HEXAHEDRON; kind <= SS_MESH_PYRAMID; ++kind) {
        if (d->found[kind] > SS_DRAFT_MAX_COUNT) {
            return fault_too_many(d);
        }
        tetrahedra += ss_mesh_cell_pieces((ss_mesh_kind)kind) * d->found[kind];
        first += d->found[kind];
    }
    if (d->node_count == 0 || triangles + quads + tetrahedra == 0) {
        fault_no_elements(d, other);
        return false;
    }
    if (triangles + 2 * quads > SS_DRAFT_MAX_COUNT || tetrahedra > SS_DRAFT_MAX_COUNT) {
        return fault_too_many(d);
    }
    if (second > 0 && first > 0) {
        ss_text_fault_file(d->text, SOFTSIM_ERROR_FORMAT,
                           "%lld cells of first order beside %lld tetrahedra of 10 nodes: mesh it "
                           "all of one order",
                           (long long)first, (long long)second);
        return false;
    }
    const bool is_surface = tetrahedra == 0;
    d->triangle_room = is_surface && triangles > 0 ? (int32_t)(triangles + 2 * quads) : (int32_t)0;
    d->quad_room = is_surface && triangles == 0 ? (int32_t)quads : 0;
    d->tetrahedron_room = (int32_t)tetrahedra;
    d->triangle = ss_memory_get((size_t)d->triangle_room, sizeof *d->triangle);
    d->quad = ss_memory_get((size_t)d->quad_room, sizeof *d->quad);
    d->tetrahedron = ss_memory_get((size_t)d->tetrahedron_room, sizeof *d->tetrahedron);
    d->middle = second > 0 ? ss_memory_get((size_t)second, sizeof *d->middle) : NULL;
    return d->triangle != NULL && d->quad != NULL && d->tetrahedron != NULL &&
                   (d->middle != NULL || second == 0)
               ? true
               : ss_text_out_of_memory(d->text);
}

static bool fault_changed(ss_draft *d)
{
    ss_text_fault_file(d->text, SOFTSIM_ERROR_FILE,
                       "it changed while it was read: read it again when it is written");
    return false;
}

/* Splits a cell; its missing pieces are those with a node twice. */
static bool add_cell(ss_draft *d, ss_mesh_kind kind, const int32_t *node)
{
    static const char *const names[SS_MESH_KIND_COUNT] = {[SS_MESH_HEXAHEDRON] = "hexahedron",
                                                          [SS_MESH_PRISM] = "prism",
                                                          [SS_MESH_PYRAMID] = "pyramid"};
    int32_t piece[SS_CELL_PIECES][4];
    const int32_t most = ss_mesh_cell_pieces(kind);
    if (d->tetrahedron_room - d->tetrahedron_count < most || d->middle != NULL) {
        return fault_changed(d);
    }
    const int count = ss_mesh_split_cell(kind, (const double(*)[3])d->position, node, piece);
    if (count <= 0) {
        ss_text_fault(d->text, "a %s that %s: correct its nodes, or their order", names[kind],
                      count < 0 ? "is folded (parts of it are inside out)" : "has no volume");
        return d->text->fault_count < SS_TEXT_MAX_FAULTS;
    }
    memcpy(d->tetrahedron[d->tetrahedron_count], piece, (size_t)count * sizeof *piece);
    d->tetrahedron_count += count;
    d->tetrahedron_room -= most - count;
    return true;
}

bool ss_draft_add_element(ss_draft *d, ss_mesh_kind kind, const int32_t *node, const int8_t *edges)
{
    if (kind == SS_MESH_TETRAHEDRON || kind == SS_MESH_TETRAHEDRON_2) {
        if (d->tetrahedron_count == d->tetrahedron_room ||
            (kind == SS_MESH_TETRAHEDRON_2) != (d->middle != NULL)) {
            return fault_changed(d);
        }
        for (int k = 0; k < 6 && d->middle != NULL; ++k) {
            d->middle[d->tetrahedron_count][edges[k]] = node[4 + k];
        }
        memcpy(d->tetrahedron[d->tetrahedron_count++], node, sizeof *d->tetrahedron);
    } else if (ss_mesh_cell_pieces(kind) > 0) {
        return add_cell(d, kind, node);
    } else if (d->tetrahedron_room > 0 || (kind != SS_MESH_TRIANGLE && kind != SS_MESH_QUAD)) {
        return true;
    } else if (d->quad_room > 0) {
        if (kind != SS_MESH_QUAD || d->quad_count == d->quad_room) {
            return fault_changed(d);
        }
        memcpy(d->quad[d->quad_count++], node, sizeof *d->quad);
    } else {
        const int32_t pieces = kind == SS_MESH_QUAD ? 2 : 1;
        if (d->triangle_room - d->triangle_count < pieces) {
            return fault_changed(d);
        }
        if (kind == SS_MESH_QUAD) {
            const ss_mesh nodes = {.node_count = d->node_count, .position = d->position};
            ss_mesh_cut_quad(&nodes, node, &d->triangle[d->triangle_count]);
            ++d->cut_count;
        } else {
            memcpy(d->triangle[d->triangle_count], node, sizeof *d->triangle);
        }
        d->triangle_count += pieces;
    }
    return true;
}

/* ---- groups ---- */

int32_t ss_draft_find_group(ss_draft *d, int64_t key, const char *name)
{
    int32_t low = 0;
    int32_t high = d->group_count;
    while (low < high) {
        const int32_t middle = (low + high) / 2;
        if (d->group[d->order[middle]].key < key) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    if (low < d->group_count && d->group[d->order[low]].key == key) {
        return d->order[low];
    }
    if (d->group_count == SS_DRAFT_MAX_GROUPS) {
        ss_text_fault_file(d->text, SOFTSIM_ERROR_FORMAT, "more than %d groups: use fewer",
                           (int)SS_DRAFT_MAX_GROUPS);
        return -1;
    }
    memmove(&d->order[low + 1], &d->order[low],
            (size_t)(d->group_count - low) * sizeof d->order[0]);
    d->order[low] = d->group_count;
    ss_draft_group *group = &d->group[d->group_count];
    group->key = key;
    (void)snprintf(group->name, sizeof group->name, "%s", name != NULL ? name : "");
    return d->group_count++;
}

/* The nodes of a list once each, in increasing order. */
static bool gather(ss_draft *d, ss_draft_group *group)
{
    const size_t words = (size_t)d->node_count / 64 + 1;
    if (d->bits == NULL) {
        d->bits = ss_memory_get(words, sizeof *d->bits);
    }
    if (d->bits == NULL) {
        return ss_text_out_of_memory(d->text);
    }
    size_t lowest = words;
    size_t highest = 0;
    for (int32_t i = 0; i < group->count; ++i) {
        const size_t word = (size_t)group->node[i] / 64;
        d->bits[word] |= (uint64_t)1 << (group->node[i] % 64);
        lowest = word < lowest ? word : lowest;
        highest = word > highest ? word : highest;
    }
    group->count = 0;
    for (size_t word = lowest; word < words && word <= highest; ++word) {
        for (uint64_t left = d->bits[word]; left != 0; left &= left - 1) {
            group->node[group->count++] = (int32_t)(64 * word) + __builtin_ctzll(left);
        }
        d->bits[word] = 0;
    }
    return true;
}

/* Room for one more node. */
static bool grow(ss_draft *d, ss_draft_group *group)
{
    if (group->count > 0 && !gather(d, group)) {
        return false;
    }
    if (group->count > 0 && group->count <= group->capacity / 2) {
        return true;
    }
    const int32_t capacity = group->capacity == 0 ? 64 : 2 * group->capacity;
    d->member_room += capacity - group->capacity;
    if (d->member_room > SS_DRAFT_MAX_MEMBERS) {
        ss_text_fault_file(d->text, SOFTSIM_ERROR_FORMAT,
                           "its groups have too many nodes together: use fewer groups");
        return false;
    }
    int32_t *node = ss_memory_get((size_t)capacity, sizeof *node);
    if (node == NULL) {
        return ss_text_out_of_memory(d->text);
    }
    if (group->count > 0) {
        memcpy(node, group->node, (size_t)group->count * sizeof *node);
    }
    ss_memory_free(group->node);
    group->node = node;
    group->capacity = capacity;
    return true;
}

bool ss_draft_mark(ss_draft *d, int32_t group, int32_t node)
{
    ss_draft_group *g = &d->group[group];
    if (g->count == g->capacity && !grow(d, g)) {
        return false;
    }
    g->node[g->count++] = node;
    return true;
}

/* ---- fields ---- */

bool ss_draft_make_field(ss_draft *d, ss_draft_field *field, int64_t count)
{
    *field = (ss_draft_field){0};
    field->code = ss_memory_get((size_t)count, sizeof *field->code);
    return field->code != NULL ? true : ss_text_out_of_memory(d->text);
}

void ss_draft_set_field(ss_draft_field *field, int64_t i, int64_t value)
{
    if (field->names_none) {
        return;
    }
    if (field->value_count == 0 || field->value[field->last] != value) {
        int32_t code = 0;
        while (code < field->value_count && field->value[code] != value) {
            ++code;
        }
        if (code == SS_DRAFT_MAX_VALUES) {
            field->names_none = true;
            return;
        }
        field->value[code] = value;
        field->value_count += code == field->value_count;
        field->last = (uint8_t)code;
    }
    field->code[i] = field->last;
}

static const char mask_prefix[] = "group:";

static bool is_mask(const ss_draft_field *field, const char *name)
{
    bool is = strncmp(name, mask_prefix, sizeof mask_prefix - 1) == 0 &&
              name[sizeof mask_prefix - 1] != '\0';
    for (int32_t i = 0; i < field->value_count; ++i) {
        is = is && (field->value[i] == 0 || field->value[i] == 1);
    }
    return is;
}

bool ss_draft_name_field(ss_draft *d, ss_draft_field *field, const char *name, int32_t ordinal)
{
    const bool is_masked = is_mask(field, name);
    for (int32_t i = 0; i < field->value_count && !field->names_none; ++i) {
        int32_t rank = 0;
        for (int32_t k = 0; k < field->value_count; ++k) {
            rank += field->value[k] < field->value[i];
        }
        char text[2 * sizeof d->group[0].name];
        const int length =
            is_masked ? snprintf(text, sizeof text, "%s", name + sizeof mask_prefix - 1)
                      : snprintf(text, sizeof text, "%s=%lld", name, (long long)field->value[i]);
        if (length < 0 || (size_t)length >= sizeof d->group[0].name) {
            field->names_none = true;
            return true;
        }
        field->group[i] = is_masked && field->value[i] == 0
                              ? -1
                              : ss_draft_find_group(d, ((int64_t)ordinal << 8) + rank, text);
        if (field->group[i] < 0 && !(is_masked && field->value[i] == 0)) {
            return false;
        }
    }
    return true;
}

int32_t ss_draft_field_group(const ss_draft_field *field, int64_t i)
{
    return field->names_none || field->value_count == 0 ? -1 : field->group[field->code[i]];
}

void ss_draft_field_fini(ss_draft_field *field)
{
    ss_memory_free(field->code);
    field->code = NULL;
}

const char *ss_mesh_kind_name(ss_mesh_kind kind)
{
    static const char *const names[] = {
        [SS_MESH_POINT] = "points",
        [SS_MESH_LINE] = "lines",
        [SS_MESH_LINE_2] = "lines of second order",
        [SS_MESH_TRIANGLE] = "triangles",
        [SS_MESH_QUAD] = "quads",
        [SS_MESH_TETRAHEDRON] = "tetrahedra",
        [SS_MESH_TETRAHEDRON_2] = "tetrahedra of second order",
        [SS_MESH_POLYGON] = "polygons and strips",
        [SS_MESH_TRIANGLE_2] = "triangles of second order",
        [SS_MESH_HEXAHEDRON] = "hexahedra",
        [SS_MESH_PRISM] = "prisms",
        [SS_MESH_PYRAMID] = "pyramids",
        [SS_MESH_HIGHER_ORDER] = "elements of higher order",
        [SS_MESH_OTHER] = "elements of other kinds",
    };
    return names[kind];
}

/* ---- the mesh ---- */

/* Groups of one name are one group, at the place of the first. */
static bool join_groups(ss_draft *d)
{
    for (int32_t i = 0; i < d->group_count; ++i) {
        ss_draft_group *group = &d->group[d->order[i]];
        for (int32_t k = 0; k < i; ++k) {
            const int32_t first = d->order[k];
            if (group->count == 0 || d->group[first].count == 0 ||
                strcmp(d->group[first].name, group->name) != 0) {
                continue;
            }
            for (int32_t n = 0; n < group->count; ++n) {
                if (!ss_draft_mark(d, first, group->node[n])) {
                    return false;
                }
            }
            group->count = 0;
        }
    }
    return true;
}

static bool hand_over_groups(ss_draft *d, ss_mesh *mesh)
{
    int32_t count = 0;
    for (int32_t g = 0; g < d->group_count; ++g) {
        ss_plain_clean(d->group[g].name); /* goes to files too, where a line ends a name */
    }
    if (!join_groups(d)) {
        return false;
    }
    for (int32_t g = 0; g < d->group_count; ++g) {
        count += d->group[g].count > 0;
    }
    mesh->group = ss_memory_get((size_t)count, sizeof *mesh->group);
    if (mesh->group == NULL) {
        return ss_text_out_of_memory(d->text);
    }
    for (int32_t i = 0; i < d->group_count; ++i) {
        ss_draft_group *group = &d->group[d->order[i]];
        if (group->count == 0) {
            continue;
        }
        ss_mesh_group *out = &mesh->group[mesh->group_count];
        if (!gather(d, group) ||
            (out->node = ss_memory_get((size_t)group->count, sizeof *out->node)) == NULL) {
            return ss_text_out_of_memory(d->text);
        }
        memcpy(out->node, group->node, (size_t)group->count * sizeof *out->node);
        out->node_count = group->count;
        memcpy(out->name, group->name, sizeof out->name);
        ++mesh->group_count;
        ss_memory_free(group->node);
        group->node = NULL;
    }
    return true;
}

static void count_skipped(const ss_draft *d, ss_mesh *mesh)
{
    const bool is_volume = d->tetrahedron_room > 0;
    for (int kind = 0; kind < SS_MESH_KIND_COUNT; ++kind) {
        const bool is_face = kind == SS_MESH_TRIANGLE || kind == SS_MESH_QUAD;
        const bool is_kept = ss_draft_is_volume((ss_mesh_kind)kind) || (is_face && !is_volume);
        mesh->skipped[kind] = is_kept ? 0 : d->found[kind];
        mesh->split[kind] = ss_mesh_cell_pieces((ss_mesh_kind)kind) > 0 ? d->found[kind] : 0;
    }
}

static bool hand_over(ss_draft *d, ss_mesh *mesh)
{
    if (d->triangle_count != d->triangle_room || d->quad_count != d->quad_room ||
        d->tetrahedron_count != d->tetrahedron_room) {
        return fault_changed(d);
    }
    count_skipped(d, mesh);
    if (!hand_over_groups(d, mesh)) {
        return false;
    }
    ss_memory_free(d->tag);
    d->tag = NULL;
    mesh->node_count = d->node_count;
    mesh->position = d->position;
    mesh->tetrahedron_count = d->tetrahedron_count;
    mesh->tetrahedron = d->tetrahedron;
    mesh->middle = d->middle;
    mesh->quad_count = d->quad_count;
    mesh->quad = d->quad;
    mesh->triangle_count = d->triangle_count;
    mesh->triangle = d->triangle;
    mesh->cut_face_count = d->cut_count;
    d->position = NULL;
    d->tetrahedron = NULL;
    d->middle = NULL;
    d->quad = NULL;
    d->triangle = NULL;
    return true;
}

softsim_status ss_draft_finish(ss_draft *d, ss_mesh **out_mesh)
{
    ss_mesh *mesh = ss_memory_get(1, sizeof *mesh);
    bool is_done = mesh != NULL && hand_over(d, mesh);
    if (is_done && mesh->tetrahedron_count > 0) {
        ss_memory_free(mesh->triangle);
        mesh->triangle = NULL;
        is_done = ss_mesh_extract_surface(mesh);
    } else if (is_done && mesh->quad_count > 0) {
        ss_memory_free(mesh->triangle);
        mesh->triangle_count = 2 * mesh->quad_count;
        mesh->triangle = ss_memory_get((size_t)mesh->triangle_count, sizeof *mesh->triangle);
        is_done = mesh->triangle != NULL && ss_mesh_arrange_quads(mesh);
    }
    is_done = is_done && ss_mesh_find_closed(mesh);
    if (!is_done && d->text->fault_count == 0) {
        (void)ss_text_out_of_memory(d->text);
    }
    if (!is_done) {
        ss_mesh_destroy(&mesh);
    }
    *out_mesh = mesh;
    return is_done ? SOFTSIM_OK : d->text->status;
}
