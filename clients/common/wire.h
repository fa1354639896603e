/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Our two fixed-size messages to and from bytes. Decoding asks for exactly the encoded size first
 * (decoders are softsim_log_decode_pose and softsim_log_decode_force in softsim/log.h).
 */
#include <stdint.h>

#include "softsim/types.h"

/* Bytes of an encoded probe_pose_t and contact_force_t, the 8 of the type hash included. */
enum { SS_WIRE_POSE_SIZE = 148, SS_WIRE_FORCE_SIZE = 216 };

/* Thread: any; no allocation. */
void ss_wire_encode_pose(const softsim_pose *pose, uint8_t out[SS_WIRE_POSE_SIZE]);
void ss_wire_encode_force(const softsim_force *force, uint8_t out[SS_WIRE_FORCE_SIZE]);
