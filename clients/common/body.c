/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "body.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TOPOLOGY_FRAME = 1, DELTA_FRAME = 2, FIELD_FRAME = 3 };

/* ---- messages of the server ---- */

void ss_body_free(ss_body_view *body)
{
    free(body->block);
    *body = (ss_body_view){.generation = body->generation, .change = body->change, .newest = -1};
}

/* Touches no more of the memory than was touched before: of the nodes that have moved. */
void ss_body_begin_session(ss_body_view *body)
{
    if (body->topology == 0) {
        return;
    }
    for (int32_t node = body->newest; node >= 0; node = body->older[node]) {
        memset(body->displacement[node], 0, sizeof body->displacement[0]);
        body->node_change[node] = 0;
    }
    if (body->field_change != 0) {
        memset(body->field, 0, (size_t)body->node_count * sizeof body->field[0]);
    }
    body->newest = -1;
    body->field_change = 0;
    body->generation += body->is_complete ? 1 : 0;
}

/* The next part of a block. */
static void *take_part(uint8_t **at, size_t count, size_t size)
{
    void *part = *at;
    *at += count * size;
    return part;
}

/* All arrays in one block. The message that begins a topology may be forged, and announces up to
 * 260 MB: a block of more than 32 MB is the system's own, zero, and becomes memory where it is
 * written, so that a body costs what has come of it. Arrays of their own, below that size, are
 * cleared by the C library once a block like them was freed, and cost all that is announced. */
static bool get_memory(ss_body_view *body, size_t nodes, size_t triangles)
{
    enum { NODE = 38, TRIANGLE = 13 }; /* bytes */
    body->block = calloc(1, nodes * NODE + triangles * TRIANGLE);
    if (body->block == NULL) {
        return false;
    }
    uint8_t *at = body->block;
    body->node_change = take_part(&at, nodes, sizeof body->node_change[0]);
    body->rest = take_part(&at, nodes, sizeof body->rest[0]);
    body->newer = take_part(&at, nodes, sizeof body->newer[0]);
    body->older = take_part(&at, nodes, sizeof body->older[0]);
    body->triangle = take_part(&at, triangles, sizeof body->triangle[0]);
    body->displacement = take_part(&at, nodes, sizeof body->displacement[0]);
    body->field = take_part(&at, nodes, sizeof body->field[0]);
    body->flag = take_part(&at, nodes, 1);
    body->has_node = take_part(&at, nodes, 1);
    body->has_triangle = take_part(&at, triangles, 1);
    return true;
}

static bool begin_topology(ss_body_view *body, const softsim_topology_chunk *chunk)
{
    ss_body_free(body);
    if (chunk->node_count < 1 || chunk->node_count > SS_BODY_MAX_NODES ||
        chunk->triangle_count > SS_BODY_MAX_TRIANGLES ||
        !get_memory(body, (size_t)chunk->node_count, (size_t)chunk->triangle_count)) {
        return false;
    }
    body->topology = chunk->topology;
    body->node_count = body->nodes_missing = chunk->node_count;
    body->triangle_count = body->triangles_missing = chunk->triangle_count;
    body->scale = chunk->scale;
    return true;
}

bool ss_body_take_topology(ss_body_view *body, const softsim_topology_chunk *chunk)
{
    if ((chunk->topology != body->topology || chunk->node_count != body->node_count ||
         chunk->triangle_count != body->triangle_count || chunk->scale != body->scale) &&
        !begin_topology(body, chunk)) {
        return false;
    }
    if (body->is_complete) {
        return true;
    }
    for (int32_t i = 0; i < chunk->node_chunk; ++i) {
        const int32_t node = chunk->first_node + i;
        memcpy(body->rest[node], chunk->rest + 3 * (size_t)i, sizeof body->rest[0]);
        body->flag[node] = chunk->node_flag[i];
        body->nodes_missing -= body->has_node[node] == 0;
        body->has_node[node] = 1;
    }
    for (int32_t i = 0; i < chunk->triangle_chunk; ++i) {
        const int32_t triangle = chunk->first_triangle + i;
        memcpy(body->triangle[triangle], chunk->triangle + 3 * (size_t)i, sizeof body->triangle[0]);
        body->triangles_missing -= body->has_triangle[triangle] == 0;
        body->has_triangle[triangle] = 1;
    }
    if (body->nodes_missing == 0 && body->triangles_missing == 0) {
        body->is_complete = true;
        ++body->generation;
    }
    return true;
}

/* To the list's beginning, with the number of this change. */
static void note_change(ss_body_view *body, int32_t node, uint64_t change)
{
    if (body->node_change[node] != 0) {
        if (body->newest == node) {
            body->newest = body->older[node];
        } else {
            body->older[body->newer[node]] = body->older[node];
        }
        if (body->older[node] >= 0) {
            body->newer[body->older[node]] = body->newer[node];
        }
    }
    body->node_change[node] = change;
    body->newer[node] = -1;
    body->older[node] = body->newest;
    if (body->newest >= 0) {
        body->newer[body->newest] = node;
    }
    body->newest = node;
}

void ss_body_take_delta(ss_body_view *body, const softsim_mesh_delta *delta)
{
    const uint64_t change = body->change + 1;
    if (delta->topology != body->topology) {
        return;
    }
    for (int32_t i = 0; i < delta->count; ++i) {
        const int32_t node = delta->node[i];
        const int16_t *displacement = delta->displacement + 3 * (size_t)i;
        if (node < body->node_count &&
            memcmp(body->displacement[node], displacement, sizeof body->displacement[0]) != 0) {
            memcpy(body->displacement[node], displacement, sizeof body->displacement[0]);
            note_change(body, node, change);
            body->change = change;
        }
    }
}

void ss_body_take_field(ss_body_view *body, const softsim_mesh_field *field)
{
    if (field->topology != body->topology || field->first_node > body->node_count ||
        field->count > body->node_count - field->first_node) {
        return;
    }
    memcpy(body->field + field->first_node, field->value,
           (size_t)field->count * sizeof body->field[0]);
    body->field_low = field->low;
    body->field_high = field->high;
    snprintf(body->field_name, sizeof body->field_name, "%s", field->name);
    snprintf(body->field_unit, sizeof body->field_unit, "%s", field->unit);
    ++body->field_change;
}

/* ---- messages to a browser ---- */

typedef struct frame {
    uint8_t *start, *at;
    size_t before;
} frame;

static bool begin_frame(frame *f, size_t before, size_t size, uint8_t kind)
{
    f->start = malloc(before + size);
    f->before = before;
    if (f->start != NULL) {
        f->at = f->start + before;
        const uint8_t head[4] = {kind};
        memcpy(f->at, head, sizeof head);
        f->at += sizeof head;
    }
    return f->start != NULL;
}

/* Little-endian, as every machine that this runs on is. */
static void put(frame *f, const void *data, size_t size)
{
    memcpy(f->at, data, size);
    f->at += size;
}

static uint8_t *end_frame(const frame *f, size_t *out_size)
{
    *out_size = (size_t)(f->at - f->start) - f->before;
    return f->start;
}

static uint8_t *topology_frame(const ss_body_view *body, ss_body_copy *copy, size_t before,
                               size_t *out_size)
{
    const size_t nodes = (size_t)body->node_count, triangles = (size_t)body->triangle_count;
    frame f = {0};
    if (!begin_frame(&f, before, 16 + nodes * 13 + triangles * 12, TOPOLOGY_FRAME)) {
        return NULL;
    }
    put(&f, &body->node_count, 4);
    put(&f, &body->triangle_count, 4);
    put(&f, &body->scale, 4);
    put(&f, body->rest, nodes * sizeof body->rest[0]);
    put(&f, body->triangle, triangles * sizeof body->triangle[0]);
    put(&f, body->flag, nodes);
    *copy = (ss_body_copy){.generation = body->generation};
    return end_frame(&f, out_size);
}

static uint8_t *delta_frame(const ss_body_view *body, ss_body_copy *copy, size_t before,
                            size_t *out_size)
{
    uint32_t count = 0;
    int32_t node = body->newest;
    for (; node >= 0 && body->node_change[node] > copy->change; node = body->older[node]) {
        ++count;
    }
    frame f = {0};
    if (count == 0 || !begin_frame(&f, before, 8 + (size_t)count * 10, DELTA_FRAME)) {
        return NULL;
    }
    copy->change = body->change;
    put(&f, &count, 4);
    uint8_t *numbers = f.at + (size_t)count * 4; /* behind the nodes */
    node = body->newest;
    for (uint32_t i = 0; i < count; ++i, node = body->older[node]) {
        put(&f, &node, 4);
        memcpy(numbers, body->displacement[node], sizeof body->displacement[0]);
        numbers += sizeof body->displacement[0];
    }
    f.at = numbers;
    return end_frame(&f, out_size);
}

static uint8_t *field_frame(const ss_body_view *body, ss_body_copy *copy, size_t before,
                            size_t *out_size)
{
    frame f = {0};
    if (!begin_frame(&f, before,
                     16 + sizeof body->field_name + sizeof body->field_unit +
                         (size_t)body->node_count * 2,
                     FIELD_FRAME)) {
        return NULL;
    }
    copy->field_change = body->field_change;
    put(&f, &body->node_count, 4);
    put(&f, &body->field_low, 4);
    put(&f, &body->field_high, 4);
    put(&f, body->field_name, sizeof body->field_name);
    put(&f, body->field_unit, sizeof body->field_unit);
    put(&f, body->field, (size_t)body->node_count * 2);
    return end_frame(&f, out_size);
}

bool ss_body_has_topology(const ss_body_view *body, const ss_body_copy *copy)
{
    return !body->is_complete || copy->generation == body->generation;
}

uint8_t *ss_body_frame(const ss_body_view *body, ss_body_copy *copy, size_t before,
                       size_t *out_size)
{
    if (!body->is_complete) {
        return NULL;
    }
    if (!ss_body_has_topology(body, copy)) {
        return topology_frame(body, copy, before, out_size);
    }
    const bool has_field = copy->field_change != body->field_change;
    uint8_t *message = NULL;
    if (copy->change != body->change && !(has_field && copy->is_turn_of_field)) {
        message = delta_frame(body, copy, before, out_size);
    }
    copy->is_turn_of_field = message != NULL;
    return message == NULL && has_field ? field_frame(body, copy, before, out_size) : message;
}
