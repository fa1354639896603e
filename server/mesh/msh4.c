/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Sections of Gmsh MSH 4.1 text (Gmsh's manual, "MSH file format"):
 *
 *   $Entities / points curves surfaces volumes
 *     point: tag x y z physical-count physical ...
 *     others: tag min-x min-y min-z max-x max-y max-z physical-count physical ...
 *             boundary-count boundary ...
 *   $Nodes / blocks nodes least-tag greatest-tag
 *     block: dimension entity parametric node-count / tags, a line each / x y z [u v w] ...
 *   $Elements / blocks elements least-tag greatest-tag
 *     block: dimension entity type element-count / tag nodes ...
 *
 * An element is in the physical groups of its block's entity; there may be several. Physical
 * numbers are negative where an entity is reversed: the group is the same.
 */
#include "mesh/msh4.h"

#include "mesh/second_order.h"
#include "rt/memory.h"
#include "rt/order.h"

#include <stdlib.h>
#include <string.h>

/* Bytes of the shortest records. */
enum { MIN_ENTITY = 9, MIN_NODE = 7, MIN_ELEMENT = 3 };

/* ---- entities ---- */

/* Takes one entity's line. Its groups are made and listed when `group` has room for them. */
static bool read_entity(ss_msh *r, int32_t dimension, ss_msh_entity *out, int32_t *group)
{
    ss_text_span line;
    double skipped = 0.0;
    int64_t count = 0;
    bool is_good = ss_text_next_line(r->text, &line) && ss_span_next_int64(&line, &out->tag);
    for (int k = 0; k < (dimension == 0 ? 3 : 6) && is_good; ++k) {
        is_good = ss_span_next_number(&line, &skipped);
    }
    is_good =
        is_good && ss_span_next_int32(&line, &count) && count >= 0 && count <= SS_DRAFT_MAX_GROUPS;
    out->dimension = dimension;
    out->group_count = (int32_t)count;
    for (int64_t i = 0; i < count && is_good; ++i) {
        int64_t number = 0;
        is_good = ss_span_next_int32(&line, &number);
        if (is_good && group != NULL) {
            group[i] = ss_msh_find_group(r, dimension, number < 0 ? -number : number);
            if (group[i] < 0) {
                return false;
            }
        }
    }
    if (!is_good) {
        ss_text_fault(r->text,
                      "an entity of dimension %d expected here: its number, %s, the count of its "
                      "physical groups (at most %d) and they",
                      dimension, dimension == 0 ? "x y z" : "its box", (int)SS_DRAFT_MAX_GROUPS);
    }
    return is_good;
}

static int compare_entities(const void *left, const void *right)
{
    const ss_msh_entity *a = left, *b = right;
    return ss_order_then(ss_order_int(a->dimension, b->dimension), ss_order_int(a->tag, b->tag));
}

/* Goes over the entities; with `group` NULL to count their groups. */
static bool go_over_entities(ss_msh *r, const int64_t count[4], int32_t *group)
{
    int64_t entity = 0;
    int64_t used = 0;
    for (int32_t dimension = 0; dimension < 4; ++dimension) {
        for (int64_t i = 0; i < count[dimension]; ++i, ++entity) {
            ss_msh_entity *e = &r->entity[entity];
            if (group != NULL && used + e->group_count > r->group_count) {
                ss_text_fault(r->text, "the file changed while it was read: read it again");
                return false;
            }
            e->first_group = used;
            if (!read_entity(r, dimension, e, group != NULL ? group + used : NULL)) {
                return false;
            }
            used += e->group_count;
        }
    }
    r->group_count = used;
    return true;
}

bool ss_msh4_read_entities(ss_msh *r)
{
    ss_text_span line;
    int64_t count[4] = {0};
    if (r->entity != NULL) {
        ss_text_fault(r->text, "a second %s section: remove it", "$Entities");
        return false;
    }
    bool is_good = ss_text_next_line(r->text, &line);
    for (int k = 0; k < 4 && is_good; ++k) {
        is_good = ss_span_next_int32(&line, &count[k]) && count[k] >= 0;
        r->entity_count += count[k];
    }
    if (!is_good || !ss_span_is_blank(line)) {
        ss_text_fault(r->text, "the numbers of points, curves, surfaces and volumes expected here");
        return false;
    }
    if (!ss_msh_has_room(r, r->entity_count, MIN_ENTITY, "entities")) {
        return false;
    }
    r->entity = ss_memory_get((size_t)r->entity_count, sizeof *r->entity);
    if (r->entity == NULL) {
        return ss_text_out_of_memory(r->text);
    }
    const ss_text_mark start = ss_text_here(r->text);
    if (!go_over_entities(r, count, NULL)) {
        return false;
    }
    r->group = ss_memory_get((size_t)r->group_count, sizeof *r->group);
    if (r->group == NULL) {
        return ss_text_out_of_memory(r->text);
    }
    ss_text_seek(r->text, start);
    if (!go_over_entities(r, count, r->group)) {
        return false;
    }
    qsort(r->entity, (size_t)r->entity_count, sizeof *r->entity, compare_entities);
    return ss_msh_expect_end(r, "$EndEntities");
}

/* An entity that the file does not describe has no groups. */
static const ss_msh_entity *find_entity(const ss_msh *r, int64_t dimension, int64_t tag)
{
    const ss_msh_entity key = {.dimension = (int32_t)dimension, .tag = tag};
    return r->entity_count > 0 ? bsearch(&key, r->entity, (size_t)r->entity_count,
                                         sizeof *r->entity, compare_entities)
                               : NULL;
}

/* ---- blocks ---- */

/* A line of four numbers, the first and last of which count something. */
static bool read_four(ss_msh *r, const char *what, int64_t out[4])
{
    ss_text_span line;
    bool is_good = ss_text_next_line(r->text, &line);
    for (int k = 0; k < 4 && is_good; ++k) {
        is_good = ss_span_next_int64(&line, &out[k]);
    }
    if (!is_good || !ss_span_is_blank(line) || out[0] < 0 || out[3] < 0) {
        ss_text_fault(r->text,
                      "%s expected here, four numbers: the counts before do not fit, or "
                      "the file is cut off",
                      what);
        return false;
    }
    return true;
}

/* The same at the head of a section: blocks, records, and two tags of no concern to us. */
static bool read_head(ss_msh *r, const char *what, int64_t least, int64_t out[4])
{
    if (!read_four(r, "the numbers of blocks and records, the least and the greatest tag", out)) {
        return false;
    }
    if (out[1] < 0) {
        ss_text_fault(r->text, "%lld %s announced: the file is damaged", (long long)out[1], what);
        return false;
    }
    return ss_msh_has_room(r, out[1], least, what);
}

/* The same for a block of at most `left` records: dimension, entity, detail, count. */
static bool read_block(ss_msh *r, const char *what, int64_t left, int64_t out[4])
{
    if (!read_four(r, what, out)) {
        return false;
    }
    if (out[0] > 3 || out[3] > left) {
        ss_text_fault(r->text,
                      "%s: dimension %lld, %lld records, but dimensions end at 3 and %lld records "
                      "are left of those announced",
                      what, (long long)out[0], (long long)out[3], (long long)left);
        return false;
    }
    return true;
}

/* ---- nodes ---- */

static bool read_node_tag(ss_msh *r, int32_t index)
{
    ss_text_span line;
    ss_draft_tag *tag = &r->draft->tag[index];
    if (!ss_text_next_line(r->text, &line) || !ss_span_next_int64(&line, &tag->tag) ||
        tag->tag < 1 || !ss_span_is_blank(line)) {
        ss_text_fault(r->text, "node %d: its number (1 or more) expected here", index);
        return false;
    }
    tag->index = index;
    tag->line = r->text->line;
    return true;
}

static bool read_position(ss_msh *r, int32_t index, int64_t parameters)
{
    ss_text_span line;
    double x[3];
    double skipped = 0.0;
    bool is_good = ss_text_next_line(r->text, &line);
    for (int k = 0; k < 3 && is_good; ++k) {
        is_good = ss_span_next_number(&line, &x[k]);
    }
    for (int64_t k = 0; k < parameters && is_good && !ss_span_is_blank(line); ++k) {
        is_good = ss_span_next_number(&line, &skipped);
    }
    if (!is_good || !ss_span_is_blank(line)) {
        ss_text_fault(r->text, "node %d: its x y z expected here", index);
        return false;
    }
    return ss_draft_put_node(r->draft, index, x);
}

bool ss_msh4_read_nodes(ss_msh *r)
{
    int64_t head[4] = {0};
    if (!read_head(r, "nodes", MIN_NODE, head) || !ss_draft_make_nodes(r->draft, head[1], true)) {
        return false;
    }
    int32_t done = 0;
    for (int64_t b = 0; b < head[0]; ++b) {
        int64_t block[4] = {0};
        if (!read_block(r, "a block of nodes", head[1] - done, block)) {
            return false;
        }
        const int32_t end = done + (int32_t)block[3];
        for (int32_t i = done; i < end; ++i) {
            if (!read_node_tag(r, i)) {
                return false;
            }
        }
        for (; done < end; ++done) {
            if (!read_position(r, done, block[2] != 0 ? block[0] : 0)) {
                return false;
            }
        }
    }
    if (done < head[1]) {
        ss_text_fault(r->text, "%lld nodes announced, but the blocks have %d: the file is damaged",
                      (long long)head[1], done);
        return false;
    }
    return ss_msh_expect_end(r, "$EndNodes") && ss_draft_sort_tags(r->draft);
}

/* ---- elements ---- */

static bool count_kinds(ss_msh *r, const int64_t head[4])
{
    int64_t done = 0;
    for (int64_t b = 0; b < head[0]; ++b) {
        int64_t block[4] = {0};
        if (!read_block(r, "a block of elements", head[1] - done, block)) {
            return false;
        }
        const ss_mesh_kind kind = ss_msh_kind(block[2]);
        r->draft->found[kind] += block[3];
        if (block[3] > 0) {
            ss_msh_note_other(r, done, block[2]);
        }
        for (const int64_t end = done + block[3]; done < end; ++done) {
            ss_text_span line;
            if (!ss_text_next_line(r->text, &line) || *line.begin == '$') {
                ss_text_fault(r->text, "the text ends at element %lld of %lld: the file is cut off",
                              (long long)done, (long long)head[1]);
                return false;
            }
        }
    }
    if (done < head[1]) {
        ss_text_fault(r->text,
                      "%lld elements announced, but the blocks have %lld: the file is damaged",
                      (long long)head[1], (long long)done);
        return false;
    }
    return true;
}

static bool keep_element(ss_msh *r, const ss_msh_entity *entity, ss_mesh_kind kind,
                         const int32_t *node)
{
    for (int32_t g = 0; entity != NULL && g < entity->group_count; ++g) {
        for (int k = 0; k < ss_draft_nodes(kind); ++k) {
            if (!ss_draft_mark(r->draft, r->group[entity->first_group + g], node[k])) {
                return false;
            }
        }
    }
    return ss_draft_add_element(r->draft, kind, node, ss_mesh_edges_of_gmsh);
}

static bool read_element(ss_msh *r, int64_t index, int64_t type, const ss_msh_entity *entity)
{
    ss_text_span line;
    int64_t tag = 0;
    int32_t node[SS_DRAFT_MAX_NODES] = {0};
    const ss_mesh_kind kind = ss_msh_kind(type);
    const int nodes = ss_draft_nodes(kind);
    bool is_good = ss_text_next_line(r->text, &line) && ss_span_next_int64(&line, &tag);
    for (int k = 0; k < nodes && is_good; ++k) {
        is_good = ss_span_next_int64(&line, &tag);
        node[k] = is_good ? ss_msh_find_node(r, index, tag) : -1;
        if (is_good && node[k] < 0) {
            return r->text->fault_count < SS_TEXT_MAX_FAULTS;
        }
    }
    if (!is_good || (nodes > 0 && !ss_span_is_blank(line))) {
        ss_text_fault(r->text,
                      "element %lld, a %s: its number and then %d node numbers expected "
                      "here",
                      (long long)index, ss_msh_type_name(type), nodes);
        return false;
    }
    return nodes == 0 || keep_element(r, entity, kind, node);
}

bool ss_msh4_read_elements(ss_msh *r)
{
    int64_t head[4] = {0};
    if (!read_head(r, "elements", MIN_ELEMENT, head)) {
        return false;
    }
    const ss_text_mark start = ss_text_here(r->text);
    if (!count_kinds(r, head) || !ss_msh_begin_elements(r, start)) {
        return false;
    }
    int64_t done = 0;
    for (int64_t b = 0; b < head[0]; ++b) {
        int64_t block[4] = {0};
        if (!read_block(r, "a block of elements", head[1] - done, block)) {
            return false;
        }
        const ss_msh_entity *entity = find_entity(r, block[0], block[1]);
        for (const int64_t end = done + block[3]; done < end; ++done) {
            if (!read_element(r, done, block[2], entity)) {
                return false;
            }
        }
    }
    return ss_msh_expect_end(r, "$EndElements");
}
