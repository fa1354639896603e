/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What viewers are told, to and from bytes. Decoding trusts nothing: every length is compared with
 * what is there before it is used, every number that counts something with what it counts, values
 * are finite. It allocates nothing: arrays go into the caller's room. Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>

#include "net/wire.h"
#include "softsim/view.h"

/* Room for the arrays and texts of one message. */
typedef struct ss_view_room {
    _Alignas(8) uint8_t bytes[2 * SS_WIRE_MAX_MESSAGE];
    uint32_t used;
} ss_view_room;

bool ss_view_decode_scene(const uint8_t *data, int32_t size, ss_view_room *room,
                          softsim_scene_report *out);
bool ss_view_decode_topology(const uint8_t *data, int32_t size, ss_view_room *room,
                             softsim_topology_chunk *out);
bool ss_view_decode_delta(const uint8_t *data, int32_t size, ss_view_room *room,
                          softsim_mesh_delta *out);
bool ss_view_decode_field(const uint8_t *data, int32_t size, ss_view_room *room,
                          softsim_mesh_field *out);

/* Bytes of the message; -1 when it does not fit. */
int ss_view_encode_scene(const softsim_scene_report *scene, uint8_t *out, int size);
