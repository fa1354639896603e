/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* By the bounded reader: the generated decoders would allocate what a length says. */
#include "net/view_wire.h"

#include <math.h>
#include <string.h>

#include "net/reader.h"
#include "softsim_mesh_delta_t.h"
#include "softsim_mesh_field_t.h"
#include "softsim_mesh_topology_t.h"
#include "softsim_scene_t.h"

/* What is left of a message, and where what it holds is put. */
typedef struct reader {
    ss_reader in;
    ss_view_room *room;
} reader;

static void expect(reader *r, bool is_good)
{
    r->in.has_failed |= !is_good;
}

static int32_t get_int(reader *r)
{
    return ss_read_int32(&r->in);
}

#define GET_INTS(r, ...)                                                                           \
    get_each((r), (int32_t *const[]){__VA_ARGS__},                                                 \
             sizeof((int32_t *const[]){__VA_ARGS__}) / sizeof(int32_t *))
static void get_each(reader *r, int32_t *const *out, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        *out[i] = get_int(r);
    }
}

static float get_float(reader *r)
{
    const float value = ss_read_float(&r->in);
    expect(r, isfinite(value));
    return r->in.has_failed ? 0.0f : value;
}

static double get_double(reader *r)
{
    const double value = ss_read_double(&r->in);
    expect(r, isfinite(value));
    return r->in.has_failed ? 0.0 : value;
}

/* Room for `count` values of `bytes` each, as far as as many are there. */
static void *take_room(reader *r, int32_t count, uint32_t bytes)
{
    const uint32_t aligned = (r->room->used + 7U) & ~7U;
    if (r->in.has_failed || count < 0 || (int64_t)count * bytes > r->in.left ||
        (uint64_t)count * bytes > sizeof r->room->bytes - aligned) {
        r->in.has_failed = true;
        return r->room->bytes;
    }
    r->room->used = aligned + (uint32_t)count * bytes;
    return r->room->bytes + aligned;
}

static const int32_t *get_ints(reader *r, int32_t count, int32_t least, int32_t below)
{
    int32_t *out = take_room(r, count, sizeof *out);
    for (int32_t i = 0; i < count && !r->in.has_failed; ++i) {
        out[i] = get_int(r);
        expect(r, out[i] >= least && out[i] < below);
    }
    return out;
}

static const int16_t *get_shorts(reader *r, int32_t count)
{
    int16_t *out = take_room(r, count, sizeof *out);
    for (int32_t i = 0; i < count && !r->in.has_failed; ++i) {
        out[i] = (int16_t)(uint16_t)ss_read(&r->in, 2);
    }
    return out;
}

static const float *get_floats(reader *r, int32_t count)
{
    float *out = take_room(r, count, sizeof *out);
    for (int32_t i = 0; i < count && !r->in.has_failed; ++i) {
        out[i] = get_float(r);
    }
    return out;
}

static const char *get_text(reader *r)
{
    const int32_t length = get_int(r);
    char *out = take_room(r, length, 1);
    if (r->in.has_failed || length < 1 ||
        memchr(r->in.at, '\0', (size_t)length) != r->in.at + length - 1) {
        r->in.has_failed = true;
        return "";
    }
    memcpy(out, r->in.at, (size_t)length);
    r->in.at += length;
    r->in.left -= length;
    return out;
}

static reader begin(const uint8_t *data, int32_t size, int64_t hash, ss_view_room *room)
{
    reader r = {.in = {.at = data, .left = size}, .room = room};
    room->used = 0;
    expect(&r, size <= SS_WIRE_MAX_MESSAGE && ss_read_int64(&r.in) == hash);
    return r;
}

static bool is_whole(const reader *r)
{
    return !r->in.has_failed && r->in.left == 0;
}

/* first .. first + chunk - 1 of `count`? */
static bool is_within(int32_t first, int32_t chunk, int32_t count)
{
    return first >= 0 && chunk >= 0 && count >= 0 && (int64_t)first + chunk <= count;
}

bool ss_view_decode_scene(const uint8_t *data, int32_t size, ss_view_room *room,
                          softsim_scene_report *out)
{
    reader r = begin(data, size, __softsim_scene_t_get_hash(), room);
    *out = (softsim_scene_report){.utime_us = ss_read_int64(&r.in)};
    GET_INTS(&r, &out->seq, &out->topology);
    int64_t vertices = 0;
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        const int32_t form = get_int(&r);
        expect(&r, form >= SOFTSIM_TOOL_NONE && form <= SOFTSIM_TOOL_CONVEX);
        out->form[p] = (softsim_tool_form)form;
    }
    for (int i = 0; i < 3 * SOFTSIM_MAX_PROBES; ++i) {
        out->size[i / 3][i % 3] = get_double(&r);
    }
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        out->hull_count[p] = get_int(&r);
        expect(&r, out->hull_count[p] >= 0);
        vertices += out->hull_count[p];
    }
    const int32_t floats = get_int(&r);
    expect(&r, floats == 3 * vertices);
    out->hull = get_floats(&r, floats);
    out->parameter_count = get_int(&r);
    expect(&r, out->parameter_count >= 0 && out->parameter_count <= SOFTSIM_MAX_LIVE);
    for (int32_t i = 0; i < out->parameter_count && !r.in.has_failed; ++i) {
        out->parameter[i] = get_text(&r);
    }
    out->name = get_text(&r);
    out->model = get_text(&r);
    out->field = get_text(&r);
    return is_whole(&r);
}

bool ss_view_decode_topology(const uint8_t *data, int32_t size, ss_view_room *room,
                             softsim_topology_chunk *out)
{
    reader r = begin(data, size, __softsim_mesh_topology_t_get_hash(), room);
    *out = (softsim_topology_chunk){.utime_us = ss_read_int64(&r.in)};
    int32_t rest_count, indices;
    GET_INTS(&r, &out->seq, &out->topology, &out->node_count, &out->triangle_count,
             &out->first_node, &out->node_chunk, &rest_count, &out->first_triangle, &indices);
    out->scale = get_float(&r);
    out->triangle_chunk = indices / 3;
    expect(&r, is_within(out->first_node, out->node_chunk, out->node_count) &&
                   is_within(out->first_triangle, out->triangle_chunk, out->triangle_count) &&
                   rest_count == 3 * (int64_t)out->node_chunk && indices % 3 == 0 && indices >= 0 &&
                   out->scale > 0.0f);
    out->file_node = get_ints(&r, out->node_chunk, -1, INT32_MAX);
    uint8_t *flags = take_room(&r, out->node_chunk, 1);
    for (int32_t i = 0; i < out->node_chunk && !r.in.has_failed; ++i) {
        flags[i] = (uint8_t)ss_read(&r.in, 1);
    }
    out->node_flag = flags;
    out->rest = get_floats(&r, rest_count);
    out->triangle = get_ints(&r, indices, 0, out->node_count);
    return is_whole(&r);
}

bool ss_view_decode_delta(const uint8_t *data, int32_t size, ss_view_room *room,
                          softsim_mesh_delta *out)
{
    reader r = begin(data, size, __softsim_mesh_delta_t_get_hash(), room);
    *out = (softsim_mesh_delta){.utime_us = ss_read_int64(&r.in)};
    out->step = ss_read_int64(&r.in);
    int32_t numbers;
    GET_INTS(&r, &out->seq, &out->topology, &out->count, &numbers);
    expect(&r, out->count >= 0 && numbers == 3 * (int64_t)out->count);
    out->node = get_ints(&r, out->count, 0, INT32_MAX);
    out->displacement = get_shorts(&r, numbers);
    return is_whole(&r);
}

bool ss_view_decode_field(const uint8_t *data, int32_t size, ss_view_room *room,
                          softsim_mesh_field *out)
{
    reader r = begin(data, size, __softsim_mesh_field_t_get_hash(), room);
    *out = (softsim_mesh_field){.utime_us = ss_read_int64(&r.in)};
    out->step = ss_read_int64(&r.in);
    GET_INTS(&r, &out->seq, &out->topology, &out->first_node, &out->count);
    expect(&r, out->first_node >= 0 && out->count >= 0);
    out->name = get_text(&r);
    out->unit = get_text(&r);
    out->low = get_float(&r);
    out->high = get_float(&r);
    out->value = get_shorts(&r, out->count);
    return is_whole(&r);
}

int ss_view_encode_scene(const softsim_scene_report *scene, uint8_t *out, int size)
{
    softsim_scene_t wire = {.utime = scene->utime_us,
                            .seq = scene->seq,
                            .topology = scene->topology,
                            .hull = (float *)(uintptr_t)scene->hull,
                            .parameter_count = scene->parameter_count,
                            .parameter = (char **)(uintptr_t)scene->parameter,
                            .name = (char *)(uintptr_t)scene->name,
                            .model = (char *)(uintptr_t)scene->model,
                            .field = (char *)(uintptr_t)scene->field};
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        wire.shape[p] = (int32_t)scene->form[p];
        wire.hull_count[p] = scene->hull_count[p];
        wire.hull_float_count += 3 * scene->hull_count[p];
    }
    memcpy(wire.size_m, scene->size, sizeof wire.size_m);
    return softsim_scene_t_encode(out, 0, size, &wire);
}
