/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* What viewers are told: decoded as it was encoded, and nothing of what is damaged is used. */
#include "common/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "net/view_wire.h"
#include "softsim_mesh_delta_t.h"
#include "softsim_mesh_field_t.h"
#include "softsim_mesh_topology_t.h"
#include "softsim_scene_t.h"

enum { MESSAGE_SIZE = 4096 };
static ss_view_room room;

/* ---- one good message of each ---- */

static int make_scene(uint8_t *out)
{
    static const float hull[2][3] = {{1, 2, 3}, {4, 5, 6}};
    const softsim_scene_report scene = {
        .utime_us = 77,
        .seq = 5,
        .topology = 9,
        .form = {SOFTSIM_TOOL_SPHERE, SOFTSIM_TOOL_NONE, SOFTSIM_TOOL_CONVEX},
        .size = {{0.005}},
        .hull_count = {0, 0, 2},
        .hull = hull[0],
        .parameter_count = 2,
        .parameter = {"haptic.max_force_n=8 0.01 8 N", "haptic.between_steps=local 0 2 hold|local"},
        .name = "kidney.yaml",
        .model = "cnn-energy",
        .field = "none"};
    return ss_view_encode_scene(&scene, out, MESSAGE_SIZE);
}

static int make_topology(uint8_t *out)
{
    int32_t file_node[] = {7, -1, 9}, triangle[] = {2, 3, 4};
    uint8_t flag[] = {0, 1, 0};
    float rest[] = {0, 1, 2, 3, 4, 5, 6, 7, 8};
    const softsim_mesh_topology_t wire = {.utime = 1,
                                          .seq = 2,
                                          .topology = 3,
                                          .node_count = 5,
                                          .triangle_count = 4,
                                          .first_node = 2,
                                          .node_chunk = 3,
                                          .rest_count = 9,
                                          .first_triangle = 3,
                                          .triangle_index_count = 3,
                                          .scale = 1e-5F,
                                          .file_node = file_node,
                                          .node_flag = flag,
                                          .rest = rest,
                                          .triangle = triangle};
    return softsim_mesh_topology_t_encode(out, 0, MESSAGE_SIZE, &wire);
}

static int make_delta(uint8_t *out)
{
    int32_t node[] = {4, 0};
    int16_t displacement[] = {-1, 2, -32767, 4, 5, 32767};
    const softsim_mesh_delta_t wire = {.utime = 1,
                                       .step = 1000000000000,
                                       .seq = 2,
                                       .topology = 3,
                                       .count = 2,
                                       .displacement_count = 6,
                                       .node = node,
                                       .displacement = displacement};
    return softsim_mesh_delta_t_encode(out, 0, MESSAGE_SIZE, &wire);
}

static int make_field(uint8_t *out)
{
    char name[] = "pressure", unit[] = "Pa";
    int16_t value[] = {-32767, 0, 32767};
    const softsim_mesh_field_t wire = {.utime = 1,
                                       .step = 4,
                                       .seq = 2,
                                       .topology = 3,
                                       .first_node = 2,
                                       .count = 3,
                                       .name = name,
                                       .unit = unit,
                                       .low = -5.0F,
                                       .high = 25.0F,
                                       .value = value};
    return softsim_mesh_field_t_encode(out, 0, MESSAGE_SIZE, &wire);
}

#define DECODE(name, type)                                                                         \
    static bool decode_##name(const uint8_t *data, int32_t size)                                   \
    {                                                                                              \
        type out;                                                                                  \
        return ss_view_decode_##name(data, size, &room, &out);                                     \
    }
DECODE(scene, softsim_scene_report)
DECODE(topology, softsim_topology_chunk)
DECODE(delta, softsim_mesh_delta)
DECODE(field, softsim_mesh_field)

static const struct {
    int (*make)(uint8_t *out);
    bool (*decode)(const uint8_t *data, int32_t size);
} kinds[] = {{make_scene, decode_scene},
             {make_topology, decode_topology},
             {make_delta, decode_delta},
             {make_field, decode_field}};
enum { KINDS = sizeof kinds / sizeof kinds[0] };

/* ---- claims ---- */

TEST(a_scene_comes_as_it_went)
{
    uint8_t message[MESSAGE_SIZE];
    softsim_scene_report s;
    const int size = make_scene(message);
    assert_true(ss_view_decode_scene(message, size, &room, &s));
    assert_int_equal(s.utime_us, 77);
    assert_int_equal(s.topology, 9);
    assert_int_equal(s.form[0], SOFTSIM_TOOL_SPHERE);
    assert_int_equal(s.form[2], SOFTSIM_TOOL_CONVEX);
    assert_true(s.size[0][0] == 0.005 && s.size[0][1] == 0.0);
    assert_int_equal(s.hull_count[2], 2);
    assert_true(s.hull[5] == 6.0F);
    assert_int_equal(s.parameter_count, 2);
    assert_string_equal(s.parameter[1], "haptic.between_steps=local 0 2 hold|local");
    assert_string_equal(s.name, "kidney.yaml");
    assert_string_equal(s.model, "cnn-energy");
    assert_string_equal(s.field, "none");
}

TEST(a_mesh_comes_as_it_went)
{
    uint8_t message[MESSAGE_SIZE];
    softsim_topology_chunk t;
    softsim_mesh_delta d;
    softsim_mesh_field f;
    assert_true(ss_view_decode_topology(message, make_topology(message), &room, &t));
    assert_int_equal(t.first_node + t.node_chunk, t.node_count);
    assert_int_equal(t.file_node[1], -1);
    assert_int_equal(t.file_node[2], 9);
    assert_int_equal(t.node_flag[1], 1);
    assert_true(t.rest[8] == 8.0F && t.scale == 1e-5F);
    assert_int_equal(t.triangle_chunk, 1);
    assert_int_equal(t.triangle[2], 4);
    assert_true(ss_view_decode_delta(message, make_delta(message), &room, &d));
    assert_int_equal(d.step, 1000000000000);
    assert_int_equal(d.node[0], 4);
    assert_int_equal(d.displacement[2], -32767);
    assert_int_equal(d.displacement[5], 32767);
    assert_true(ss_view_decode_field(message, make_field(message), &room, &f));
    assert_string_equal(f.name, "pressure");
    assert_string_equal(f.unit, "Pa");
    assert_true(f.low == -5.0F && f.high == 25.0F);
    assert_int_equal(f.value[2], 32767);
}

/* Every shorter message, in a block of exactly its size, so that a sanitizer sees a byte too many
 * read; every longer one; another type. */
TEST(only_whole_messages_of_the_type_are_taken)
{
    for (int k = 0; k < KINDS; ++k) {
        uint8_t message[MESSAGE_SIZE] = {0};
        const int size = kinds[k].make(message);
        assert_true(size > 0 && kinds[k].decode(message, size));
        for (int cut = 0; cut < size; ++cut) {
            uint8_t *exact = malloc(cut > 0 ? (size_t)cut : 1);
            memcpy(exact, message, (size_t)cut);
            assert_false(kinds[k].decode(exact, cut));
            free(exact);
        }
        assert_false(kinds[k].decode(message, size + 1));
        assert_false(kinds[(k + 1) % KINDS].decode(message, size));
    }
}

/* Every four bytes in turn as each hostile number: what is accepted says nothing beyond the room.
 */
TEST(no_length_is_believed)
{
    static const uint32_t hostile[] = {
        0x7fffffff, 0x80000000, 0xffffffff, 0x40000000, 0, 1, 65536, 0x7f800000 /* infinity */,
        0x7fc00000 /* NaN */};
    for (int k = 0; k < KINDS; ++k) {
        uint8_t message[MESSAGE_SIZE];
        const int size = kinds[k].make(message);
        uint8_t *exact = malloc((size_t)size);
        for (int at = 0; at + 4 <= size; ++at) {
            for (size_t h = 0; h < sizeof hostile / sizeof hostile[0]; ++h) {
                memcpy(exact, message, (size_t)size);
                for (int i = 0; i < 4; ++i) {
                    exact[at + i] = (uint8_t)(hostile[h] >> (24 - 8 * i));
                }
                kinds[k].decode(exact, size);
                assert_true(room.used <= sizeof room.bytes);
            }
        }
        free(exact);
    }
}

TEST(numbers_of_what_is_not_there_are_refused)
{
    uint8_t message[MESSAGE_SIZE];
    const int size = make_topology(message);
    enum { NODE_COUNT = 8 + 8 + 2 * 4 + 3, FIRST_NODE = NODE_COUNT + 8, TRIANGLE = 4 };
    message[NODE_COUNT] = 4; /* five nodes are told of */
    assert_false(decode_topology(message, size));
    make_topology(message);
    message[FIRST_NODE] = 3;
    assert_false(decode_topology(message, size));
    make_topology(message);
    message[size - 1] = 5; /* a corner beyond the last node */
    assert_false(decode_topology(message, size));
    make_topology(message);
    message[size - TRIANGLE] = 0x80; /* below none */
    assert_false(decode_topology(message, size));
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
