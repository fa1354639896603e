/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "body.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TOPOLOGY_FRAME = 1, DELTA_FRAME = 2, FIELD_FRAME = 3 };

/* ---- what the server says ---- */

void ss_body_free(ss_body_view *body)
{
    void *const owned[] = {body->rest,         body->triangle,     body->flag, body->has_node,
                           body->has_triangle, body->displacement, body->field};
    for (size_t i = 0; i < sizeof owned / sizeof owned[0]; ++i) {
        free(owned[i]);
    }
    *body = (ss_body_view){.generation = body->generation, .change = body->change};
}

static bool begin_topology(ss_body_view *body, const softsim_topology_chunk *chunk)
{
    ss_body_free(body);
    if (chunk->node_count < 1 || chunk->node_count > SS_BODY_MAX_NODES ||
        chunk->triangle_count > SS_BODY_MAX_TRIANGLES) {
        return false;
    }
    const size_t nodes = (size_t)chunk->node_count;
    const size_t triangles = (size_t)chunk->triangle_count + 1;
    body->rest = calloc(nodes, sizeof body->rest[0]);
    body->flag = calloc(nodes, 1);
    body->has_node = calloc(nodes, 1);
    body->displacement = calloc(nodes, sizeof body->displacement[0]);
    body->field = calloc(nodes, sizeof body->field[0]);
    body->triangle = calloc(triangles, sizeof body->triangle[0]);
    body->has_triangle = calloc(triangles, 1);
    if (body->rest == NULL || body->flag == NULL || body->has_node == NULL ||
        body->displacement == NULL || body->field == NULL || body->triangle == NULL ||
        body->has_triangle == NULL) {
        ss_body_free(body);
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

void ss_body_take_delta(ss_body_view *body, const softsim_mesh_delta *delta)
{
    if (delta->topology != body->topology) {
        return;
    }
    for (int32_t i = 0; i < delta->count; ++i) {
        if (delta->node[i] < body->node_count) {
            memcpy(body->displacement[delta->node[i]], delta->displacement + 3 * (size_t)i,
                   sizeof body->displacement[0]);
        }
    }
    ++body->change;
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

/* ---- what a browser gets ---- */

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
    int16_t(*counts)[3] = calloc(nodes, sizeof counts[0]);
    frame f = {0};
    if (counts == NULL ||
        !begin_frame(&f, before, 16 + nodes * 13 + triangles * 12, TOPOLOGY_FRAME)) {
        free(counts);
        return NULL;
    }
    put(&f, &body->node_count, 4);
    put(&f, &body->triangle_count, 4);
    put(&f, &body->scale, 4);
    put(&f, body->rest, nodes * sizeof body->rest[0]);
    put(&f, body->triangle, triangles * sizeof body->triangle[0]);
    put(&f, body->flag, nodes);
    ss_body_free_copy(copy);
    *copy = (ss_body_copy){.generation = body->generation,
                           .change = body->change - 1, /* a first delta tells what is displaced */
                           .displacement = counts};
    return end_frame(&f, out_size);
}

static uint8_t *delta_frame(const ss_body_view *body, ss_body_copy *copy, size_t before,
                            size_t *out_size)
{
    uint32_t count = 0;
    for (int32_t i = 0; i < body->node_count; ++i) {
        count +=
            memcmp(body->displacement[i], copy->displacement[i], sizeof body->displacement[0]) != 0;
    }
    frame f = {0};
    copy->change = body->change;
    if (count == 0 || !begin_frame(&f, before, 8 + (size_t)count * 10, DELTA_FRAME)) {
        return NULL;
    }
    put(&f, &count, 4);
    uint8_t *numbers = f.at + (size_t)count * 4; /* behind the nodes */
    for (uint32_t i = 0; i < (uint32_t)body->node_count; ++i) {
        if (memcmp(body->displacement[i], copy->displacement[i], sizeof body->displacement[0]) !=
            0) {
            put(&f, &i, 4);
            memcpy(numbers, body->displacement[i], sizeof body->displacement[0]);
            memcpy(copy->displacement[i], body->displacement[i], sizeof body->displacement[0]);
            numbers += sizeof body->displacement[0];
        }
    }
    f.at = numbers;
    return end_frame(&f, out_size);
}

static uint8_t *field_frame(const ss_body_view *body, ss_body_copy *copy, size_t before,
                            size_t *out_size)
{
    frame f = {0};
    copy->field_change = body->field_change;
    if (!begin_frame(&f, before,
                     16 + sizeof body->field_name + sizeof body->field_unit +
                         (size_t)body->node_count * 2,
                     FIELD_FRAME)) {
        return NULL;
    }
    put(&f, &body->node_count, 4);
    put(&f, &body->field_low, 4);
    put(&f, &body->field_high, 4);
    put(&f, body->field_name, sizeof body->field_name);
    put(&f, body->field_unit, sizeof body->field_unit);
    put(&f, body->field, (size_t)body->node_count * 2);
    return end_frame(&f, out_size);
}

bool ss_body_is_due(const ss_body_view *body, const ss_body_copy *copy)
{
    return body->is_complete &&
           (copy->generation != body->generation || copy->change != body->change ||
            copy->field_change != body->field_change);
}

uint8_t *ss_body_frame(const ss_body_view *body, ss_body_copy *copy, size_t before,
                       size_t *out_size)
{
    uint8_t *message = NULL;
    if (!body->is_complete) {
        return NULL;
    }
    if (copy->generation != body->generation) {
        return topology_frame(body, copy, before, out_size);
    }
    if (copy->change != body->change) {
        message = delta_frame(body, copy, before, out_size);
    }
    if (message == NULL && copy->field_change != body->field_change) {
        message = field_frame(body, copy, before, out_size);
    }
    return message;
}

void ss_body_free_copy(ss_body_copy *copy)
{
    free(copy->displacement);
    *copy = (ss_body_copy){0};
}
