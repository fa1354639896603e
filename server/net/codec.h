/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Our two fixed-size messages to and from bytes, for the server, the clients and their logs,
 * without LCM. Decoding asks for exactly the encoded size and type first; values are as they came.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

/* Bytes of an encoded probe_pose_t and contact_force_t, the 8 of the type hash included. */
enum { SS_WIRE_POSE_SIZE = 148, SS_WIRE_FORCE_SIZE = 216 };

/* Thread: any; no allocation. */
bool ss_wire_decode_pose(const void *data, int64_t size, softsim_pose *out);
bool ss_wire_decode_force(const void *data, int64_t size, softsim_force *out);
void ss_wire_encode_pose(const softsim_pose *from, uint8_t out[SS_WIRE_POSE_SIZE]);
void ss_wire_encode_force(const softsim_force *from, uint8_t out[SS_WIRE_FORCE_SIZE]);
