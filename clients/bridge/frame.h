/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Device frame to world frame. Each world axis is one device axis with a sign: `x,-z,y` means
 * world x = device x, world y = -device z, world z = device y. Then
 *
 *   x_world = offset + scale A x_device      f_device = force_scale A^T f_world
 *
 * Orientations: R_world = A R_device where A is a rotation. Where A is a mirror image (a
 * left-handed device) the tool's own x axis is mirrored too, R_world = A R_device M with
 * M = diag(-1, 1, 1), so that its z axis, along which tools are built, points where the device's
 * does.
 * Thread: any; after set-up nothing changes.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

typedef struct ss_frame {
    int32_t source[3]; /* device axis that feeds each world axis */
    double sign[3];
    double scale, force_scale;
    double offset_m[3];
    double quaternion[4]; /* of A, or of A M for a mirror */
    bool is_mirror;
} ss_frame;

/* `axes` like "x,-z,y", `offset` like "0,0.1,-0.02" (metres). Adds every fault to `error`. */
softsim_status ss_frame_init(ss_frame *frame, const char *axes, const char *offset, double scale,
                             double force_scale, softsim_error *error);
void ss_frame_position(const ss_frame *frame, const double device[3], double out_world[3]);
void ss_frame_velocity(const ss_frame *frame, const double device[3], double out_world[3]);
void ss_frame_orientation(const ss_frame *frame, const double device[4], double out_world[4]);
/* A force of the device in world axes, not scaled; and a world force as the device exerts it. */
void ss_frame_force_to_world(const ss_frame *frame, const double device[3], double out_world[3]);
void ss_frame_force_to_device(const ss_frame *frame, const double world[3], double out_device[3]);
