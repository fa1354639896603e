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

/* The fields of a message: SCALAR(its name on the wire, ours), ARRAY(name). */
#define POSE_LIST(SCALAR, ARRAY)                                                                   \
    SCALAR(utime, utime_us)                                                                        \
    SCALAR(sender, sender)                                                                         \
    SCALAR(seq, seq)                                                                               \
    SCALAR(probe, probe)                                                                           \
    SCALAR(buttons, buttons)                                                                       \
    SCALAR(force_seq, force_seq)                                                                   \
    SCALAR(flags, flags)                                                                           \
    ARRAY(position) ARRAY(orientation) ARRAY(velocity) ARRAY(applied_force)
#define FORCE_LIST(SCALAR, ARRAY)                                                                  \
    SCALAR(utime, utime_us)                                                                        \
    SCALAR(sender, sender)                                                                         \
    SCALAR(pose_utime, pose_utime_us)                                                              \
    SCALAR(seq, seq)                                                                               \
    SCALAR(probe, probe)                                                                           \
    SCALAR(pose_seq, pose_seq)                                                                     \
    SCALAR(contact_count, contact_count)                                                           \
    SCALAR(model_age_us, model_age_us)                                                             \
    SCALAR(flags, flags)                                                                           \
    SCALAR(depth, depth)                                                                           \
    SCALAR(stiffness, stiffness)                                                                   \
    ARRAY(force) ARRAY(torque) ARRAY(model_force) ARRAY(point) ARRAY(normal) ARRAY(proxy)

#define SCALAR_FROM_WIRE(theirs, ours) out->ours = wire.theirs;
#define ARRAY_FROM_WIRE(name)          memcpy(out->name, wire.name, sizeof wire.name);
#define SCALAR_TO_WIRE(theirs, ours)   wire.theirs = from->ours;
#define ARRAY_TO_WIRE(name)            memcpy(wire.name, from->name, sizeof wire.name);

/* Both directions of one message. */
#define CODEC(name, type, SIZE, wire_type, LIST)                                                   \
    bool ss_wire_decode_##name(const void *data, int64_t size, type *out)                          \
    {                                                                                              \
        wire_type wire;                                                                            \
        if (data == NULL || size != (SIZE) ||                                                      \
            wire_type##_decode(data, 0, (SIZE), &wire) != (SIZE)) {                                \
            return false;                                                                          \
        }                                                                                          \
        *out = (type){.seq = 0};                                                                   \
        LIST(SCALAR_FROM_WIRE, ARRAY_FROM_WIRE)                                                    \
        return true;                                                                               \
    }                                                                                              \
    void ss_wire_encode_##name(const type *from, uint8_t out[SIZE])                                \
    {                                                                                              \
        wire_type wire = {.utime = 0};                                                             \
        LIST(SCALAR_TO_WIRE, ARRAY_TO_WIRE)                                                        \
        wire_type##_encode(out, 0, (SIZE), &wire);                                                 \
    }
CODEC(pose, softsim_pose, SS_WIRE_POSE_SIZE, softsim_probe_pose_t, POSE_LIST)
CODEC(force, softsim_force, SS_WIRE_FORCE_SIZE, softsim_contact_force_t, FORCE_LIST)
