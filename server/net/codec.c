/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The generated coders do the bytes; here are the sizes and the copying of fields. Both types are
 * of fixed size, so neither direction allocates.
 */
#include "net/codec.h"

#include <string.h>

#include "softsim_contact_force_t.h"
#include "softsim_probe_pose_t.h"

bool ss_wire_decode_pose(const void *data, int64_t size, softsim_pose *out_pose)
{
    softsim_probe_pose_t wire;
    if (data == NULL || size != SS_WIRE_POSE_SIZE ||
        softsim_probe_pose_t_decode(data, 0, SS_WIRE_POSE_SIZE, &wire) != SS_WIRE_POSE_SIZE) {
        return false;
    }
    *out_pose = (softsim_pose){.utime_us = wire.utime,
                               .sender = wire.sender,
                               .seq = wire.seq,
                               .probe = wire.probe,
                               .buttons = wire.buttons,
                               .force_seq = wire.force_seq,
                               .flags = wire.flags};
    memcpy(out_pose->position, wire.position, sizeof wire.position);
    memcpy(out_pose->orientation, wire.orientation, sizeof wire.orientation);
    memcpy(out_pose->velocity, wire.velocity, sizeof wire.velocity);
    memcpy(out_pose->applied_force, wire.applied_force, sizeof wire.applied_force);
    return true;
}

bool ss_wire_decode_force(const void *data, int64_t size, softsim_force *out_force)
{
    softsim_contact_force_t wire;
    if (data == NULL || size != SS_WIRE_FORCE_SIZE ||
        softsim_contact_force_t_decode(data, 0, SS_WIRE_FORCE_SIZE, &wire) != SS_WIRE_FORCE_SIZE) {
        return false;
    }
    *out_force = (softsim_force){.utime_us = wire.utime,
                                 .sender = wire.sender,
                                 .pose_utime_us = wire.pose_utime,
                                 .seq = wire.seq,
                                 .probe = wire.probe,
                                 .pose_seq = wire.pose_seq,
                                 .contact_count = wire.contact_count,
                                 .model_age_us = wire.model_age_us,
                                 .flags = wire.flags,
                                 .depth = wire.depth,
                                 .stiffness = wire.stiffness};
    memcpy(out_force->force, wire.force, sizeof wire.force);
    memcpy(out_force->torque, wire.torque, sizeof wire.torque);
    memcpy(out_force->model_force, wire.model_force, sizeof wire.model_force);
    memcpy(out_force->point, wire.point, sizeof wire.point);
    memcpy(out_force->normal, wire.normal, sizeof wire.normal);
    memcpy(out_force->proxy, wire.proxy, sizeof wire.proxy);
    return true;
}

void ss_wire_encode_pose(const softsim_pose *pose, uint8_t out[SS_WIRE_POSE_SIZE])
{
    softsim_probe_pose_t wire = {.utime = pose->utime_us,
                                 .sender = pose->sender,
                                 .seq = pose->seq,
                                 .probe = pose->probe,
                                 .buttons = pose->buttons,
                                 .force_seq = pose->force_seq,
                                 .flags = pose->flags};
    memcpy(wire.position, pose->position, sizeof wire.position);
    memcpy(wire.orientation, pose->orientation, sizeof wire.orientation);
    memcpy(wire.velocity, pose->velocity, sizeof wire.velocity);
    memcpy(wire.applied_force, pose->applied_force, sizeof wire.applied_force);
    softsim_probe_pose_t_encode(out, 0, SS_WIRE_POSE_SIZE, &wire);
}

void ss_wire_encode_force(const softsim_force *force, uint8_t out[SS_WIRE_FORCE_SIZE])
{
    softsim_contact_force_t wire = {.utime = force->utime_us,
                                    .sender = force->sender,
                                    .pose_utime = force->pose_utime_us,
                                    .seq = force->seq,
                                    .probe = force->probe,
                                    .pose_seq = force->pose_seq,
                                    .contact_count = force->contact_count,
                                    .model_age_us = force->model_age_us,
                                    .flags = force->flags,
                                    .depth = force->depth,
                                    .stiffness = force->stiffness};
    memcpy(wire.force, force->force, sizeof wire.force);
    memcpy(wire.torque, force->torque, sizeof wire.torque);
    memcpy(wire.model_force, force->model_force, sizeof wire.model_force);
    memcpy(wire.point, force->point, sizeof wire.point);
    memcpy(wire.normal, force->normal, sizeof wire.normal);
    memcpy(wire.proxy, force->proxy, sizeof wire.proxy);
    softsim_contact_force_t_encode(out, 0, SS_WIRE_FORCE_SIZE, &wire);
}
