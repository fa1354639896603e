/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * libFuzzer over whole datagrams: the first byte chooses whether LCM's magic is put right. What is
 * taken for a message must lie within the datagram and be on a channel of the lane.
 */
#include <stdlib.h>
#include <string.h>

#include "net/receiver.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(bool holds)
{
    if (!holds) {
        abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const ss_lane lane = {.suffix = {"_PROBE_#", "_COMMAND", "_STATUS"}};
    if (size < 1 || size > 4096) {
        return 0;
    }
    const size_t rest = size - 1;
    uint8_t *datagram = malloc(rest > 0 ? rest : 1);
    memcpy(datagram, data + 1, rest);
    if ((data[0] & 1) != 0 && rest >= 4) {
        memcpy(datagram, "LC02", 4);
    }
    ss_packet packet;
    if (ss_receiver_parse(&lane, "T", datagram, (int32_t)rest, &packet)) {
        require(packet.data >= datagram && packet.size >= 0);
        require(packet.data + packet.size == datagram + rest);
        require(packet.name >= 0 && packet.name < 3);
        require((packet.name == 0) == (packet.digit >= 0 && packet.digit <= 7));
        require(strlen(packet.channel) < 64 && strncmp(packet.channel, "T_", 2) == 0);
    }
    free(datagram);
    return 0;
}
