/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * libFuzzer over what arrives from the network: the first byte chooses pose or command and whether
 * the type hash is put right (which the fuzzer would hardly find), the rest is the message.
 * Decoded poses go on through a gate. Whatever is accepted must hold what net.h promises.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "net/net.h"
#include "softsim_command_t.h"
#include "softsim_probe_pose_t.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(bool holds)
{
    if (!holds) {
        abort();
    }
}

static void try_pose(const uint8_t *message, int64_t size)
{
    static ss_gate *gate;
    static int64_t now_ns;
    if (gate == NULL) {
        const ss_gate_config config = {.used_probes = 0xff, .max_jump_m = 0.05, .period_s = 1e-3};
        gate = ss_gate_create(&config);
    }
    softsim_pose pose;
    now_ns += 1000000;
    if (ss_net_decode_pose(message, size, now_ns, &pose) != SOFTSIM_ACCEPTED) {
        return;
    }
    uint32_t epoch = 0;
    if (ss_gate_judge(gate, &pose, pose.probe, now_ns, &epoch) == SOFTSIM_ACCEPTED) {
        const double *q = pose.orientation;
        const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
        require(fabs(square - 1.0) < 1e-12);
        require(fabs(pose.position[0]) <= 100.0 && pose.probe >= 0 && pose.probe < 8);
        require(epoch > 0);
    }
}

static void try_command(const uint8_t *message, int64_t size)
{
    ss_net_command command;
    if (ss_net_decode_command(message, size, &command) == SOFTSIM_ACCEPTED) {
        require(strnlen(command.name, sizeof command.name) < sizeof command.name);
        require(strnlen(command.argument, sizeof command.argument) < sizeof command.argument);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < 1) {
        return 0;
    }
    const bool is_pose = (data[0] & 1) != 0;
    const size_t length = size - 1;
    /* Exactly as long as the message, so that one byte read beyond it is seen. */
    uint8_t *message = malloc(length > 0 ? length : 1);
    require(message != NULL);
    memcpy(message, data + 1, length);
    if ((data[0] & 2) != 0 && length >= 8) {
        const uint64_t hash = (uint64_t)(is_pose ? __softsim_probe_pose_t_get_hash()
                                                 : __softsim_command_t_get_hash());
        for (int i = 0; i < 8; ++i) {
            message[i] = (uint8_t)(hash >> (56 - 8 * i));
        }
    }
    if (is_pose) {
        try_pose(message, (int64_t)length);
    } else {
        try_command(message, (int64_t)length);
    }
    free(message);
    return 0;
}
