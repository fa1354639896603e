/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* What viewers are told by strangers. The first byte chooses the kind, whose type it is then. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "net/view_wire.h"
#include "softsim_mesh_delta_t.h"
#include "softsim_mesh_field_t.h"
#include "softsim_mesh_topology_t.h"
#include "softsim_scene_t.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static ss_view_room room;

static void put_hash(uint8_t *message, int64_t hash)
{
    for (int i = 0; i < 8; ++i) {
        message[i] = (uint8_t)((uint64_t)hash >> (56 - 8 * i));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    softsim_scene_report scene;
    softsim_topology_chunk chunk;
    softsim_mesh_delta delta;
    softsim_mesh_field field;
    if (size < 9) {
        return 0;
    }
    uint8_t *message = malloc(size - 1);
    const int32_t length = (int32_t)size - 1;
    memcpy(message, data + 1, size - 1);
    switch (data[0] % 4) {
    case 0:
        put_hash(message, __softsim_scene_t_get_hash());
        if (ss_view_decode_scene(message, length, &room, &scene) &&
            (strlen(scene.name) > size || scene.parameter_count > SOFTSIM_MAX_LIVE)) {
            abort();
        }
        break;
    case 1:
        put_hash(message, __softsim_mesh_topology_t_get_hash());
        if (ss_view_decode_topology(message, length, &room, &chunk)) {
            for (int32_t i = 0; i < 3 * chunk.triangle_chunk; ++i) {
                if (chunk.triangle[i] < 0 || chunk.triangle[i] >= chunk.node_count) {
                    abort();
                }
            }
        }
        break;
    case 2:
        put_hash(message, __softsim_mesh_delta_t_get_hash());
        if (ss_view_decode_delta(message, length, &room, &delta) && delta.count > 0 &&
            delta.node[delta.count - 1] < 0) {
            abort();
        }
        break;
    default:
        put_hash(message, __softsim_mesh_field_t_get_hash());
        if (ss_view_decode_field(message, length, &room, &field) && !isfinite(field.low)) {
            abort();
        }
        break;
    }
    free(message);
    return 0;
}
