/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "frame.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/vec.h"

static bool parse_axes(ss_frame *frame, const char *text)
{
    uint32_t used = 0;
    for (int world = 0; world < 3; ++world) {
        frame->sign[world] = *text == '-' ? -1.0 : 1.0;
        text += *text == '-' || *text == '+';
        if (*text < 'x' || *text > 'z') {
            return false;
        }
        frame->source[world] = *text - 'x';
        used |= 1u << frame->source[world];
        ++text;
        if (world < 2 && *text++ != ',') {
            return false;
        }
    }
    return used == 7u && *text == '\0';
}

static bool parse_triple(const char *text, double out[3])
{
    for (int i = 0; i < 3; ++i) {
        char *end = NULL;
        out[i] = strtod(text, &end);
        if (end == text || !isfinite(out[i]) || fabs(out[i]) > 1e3 ||
            *end != (i < 2 ? ',' : '\0')) {
            return false;
        }
        text = end + 1;
    }
    return true;
}

/* Quaternion of the rotation matrix r (Shepperd 1978: divide by the largest component). */
static void to_quaternion(double r[3][3], double out[4])
{
    const double square[4] = {1.0 + r[0][0] + r[1][1] + r[2][2], 1.0 + r[0][0] - r[1][1] - r[2][2],
                              1.0 - r[0][0] + r[1][1] - r[2][2], 1.0 - r[0][0] - r[1][1] + r[2][2]};
    int largest = 0;
    for (int i = 1; i < 4; ++i) {
        largest = square[i] > square[largest] ? i : largest;
    }
    const double twice = sqrt(square[largest]); /* 2 |q_largest| */
    const double products[4][4] = {
        {square[0], r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]},
        {r[2][1] - r[1][2], square[1], r[1][0] + r[0][1], r[0][2] + r[2][0]},
        {r[0][2] - r[2][0], r[1][0] + r[0][1], square[2], r[2][1] + r[1][2]},
        {r[1][0] - r[0][1], r[0][2] + r[2][0], r[2][1] + r[1][2], square[3]}};
    for (int i = 0; i < 4; ++i) {
        out[i] = products[largest][i] / (2.0 * twice);
    }
}

softsim_status ss_frame_init(ss_frame *frame, const char *axes, const char *offset, double scale,
                             double force_scale, softsim_error *error)
{
    const int32_t faults_before = error->fault_count;
    *frame = (ss_frame){.scale = scale, .force_scale = force_scale};
    if (!parse_axes(frame, axes)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--axes: '%.40s'; give x, y and z once each with signs, such as x,-z,y",
                          axes);
    }
    if (!parse_triple(offset, frame->offset_m)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--offset-m: '%.60s'; give three numbers in metres, such as 0,0.05,0",
                          offset);
    }
    if (error->fault_count > faults_before) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    double matrix[3][3] = {{0.0}};
    for (int world = 0; world < 3; ++world) {
        matrix[world][frame->source[world]] = frame->sign[world];
    }
    double column[3];
    ss_cross3(column, matrix[0], matrix[1]);
    frame->is_mirror = ss_dot3(column, matrix[2]) < 0.0;
    for (int world = 0; world < 3 && frame->is_mirror; ++world) {
        matrix[world][0] = -matrix[world][0]; /* A M */
    }
    to_quaternion(matrix, frame->quaternion);
    return SOFTSIM_OK;
}

/* out = s A v */
static void place(const ss_frame *frame, double s, const double v[3], double out[3])
{
    const double from[3] = {v[0], v[1], v[2]};
    for (int world = 0; world < 3; ++world) {
        out[world] = s * frame->sign[world] * from[frame->source[world]];
    }
}

void ss_frame_position(const ss_frame *frame, const double device[3], double out_world[3])
{
    place(frame, frame->scale, device, out_world);
    ss_add3(out_world, out_world, frame->offset_m);
}

void ss_frame_velocity(const ss_frame *frame, const double device[3], double out_world[3])
{
    place(frame, frame->scale, device, out_world);
}

void ss_frame_orientation(const ss_frame *frame, const double device[4], double out_world[4])
{
    /* Of a mirror: A R M = (A M)(M R M), and M R M turns about the mirrored axis backwards:
     * (w, x, y, z) becomes (w, x, -y, -z). */
    const double side = frame->is_mirror ? -1.0 : 1.0;
    const double *a = frame->quaternion;
    const double b[4] = {device[0], device[1], side * device[2], side * device[3]};
    out_world[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out_world[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    out_world[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    out_world[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

void ss_frame_force_to_world(const ss_frame *frame, const double device[3], double out_world[3])
{
    place(frame, 1.0, device, out_world);
}

void ss_frame_force_to_device(const ss_frame *frame, const double world[3], double out_device[3])
{
    const double from[3] = {world[0], world[1], world[2]};
    for (int axis = 0; axis < 3; ++axis) {
        out_device[frame->source[axis]] = frame->force_scale * frame->sign[axis] * from[axis];
    }
}
