/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
#include <math.h>

/* Of a pose, as struct or on the wire: it answers no force, is not turned, and what the device does
 * not measure is not a number. */
#define PLAIN_POSE                                                                                 \
    .force_seq = -1, .orientation = {1, 0, 0, 0}, .velocity = {NAN, NAN, NAN},                     \
    .applied_force = {NAN, NAN, NAN}
