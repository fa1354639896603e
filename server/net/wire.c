/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * LCM opened with care, and raw messages decoded with none of its trust.
 *
 * LCM 1.3.1 needs looking after: tcpq:// without its hub aborts the process at the first wait,
 * a missing multicast route is told by four lines of which one reads freed memory, and asking for
 * more receive buffer than the kernel grants warns on stderr. So the url is checked here first.
 * Generated decoders trust length fields (a 40-byte message can overflow the heap): poses are of
 * one exact size and decoded by the generated code after that was checked; commands, which hold
 * strings, are read by the bounded reader below.
 */
#include "net/wire.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "rt/vec.h"
#include "softsim_command_t.h"
#include "softsim_probe_pose_t.h"
#include "softsim_server_status_t.h"

enum {
    WANTED_BUFFER = 2097152, /* bytes: holds half a second of mesh at the default cap */
    STOCK_BUFFER = 212992,   /* the kernel's default limit */
    POSE_SIZE = 8 + 2 * 8 + 5 * 4 + 13 * 8,
    HASH_SIZE = 8
};

/* ---- opening ------------------------------------------------------------------------------ */

static int allowed_buffer(void)
{
    int allowed = STOCK_BUFFER;
    FILE *file = fopen("/proc/sys/net/core/rmem_max", "r");
    if (file != NULL) {
        if (fscanf(file, "%d", &allowed) != 1 || allowed <= 0) {
            allowed = STOCK_BUFFER;
        }
        fclose(file);
    }
    return allowed < WANTED_BUFFER ? allowed : WANTED_BUFFER;
}

/* Reads ADDRESS[:PORT] of a udpm url; empty means LCM's own default. */
static bool read_group(const char *url, struct sockaddr_in *out_group)
{
    char text[64] = "";
    const size_t length = strcspn(url, "?");
    if (length >= sizeof text) {
        return false;
    }
    memcpy(text, url, length);
    long port = 7667;
    char *colon = strchr(text, ':');
    if (colon != NULL) {
        char *end = NULL;
        *colon = '\0';
        port = strtol(colon + 1, &end, 10);
        if (end == colon + 1 || *end != '\0' || port < 1 || port > 65535) {
            return false;
        }
    }
    *out_group = (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    const char *address = text[0] != '\0' ? text : "239.255.76.67";
    return inet_pton(AF_INET, address, &out_group->sin_addr) == 1 &&
           IN_MULTICAST(ntohl(out_group->sin_addr.s_addr));
}

/* Connecting a UDP socket sends nothing and tells whether there is a route. */
static bool has_route(const struct sockaddr_in *group)
{
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0) {
        return true; /* not for this check to say: LCM will */
    }
    const bool is_unreachable =
        connect(fd, (const struct sockaddr *)group, sizeof *group) != 0 && errno == ENETUNREACH;
    close(fd);
    return !is_unreachable;
}

lcm_t *ss_wire_open(const char *lcm_url, softsim_error *error)
{
    char fallback[96];
    const char *url = lcm_url;
    if (url == NULL || url[0] == '\0') {
        url = getenv("LCM_DEFAULT_URL");
    }
    if (url == NULL || url[0] == '\0') {
        snprintf(fallback, sizeof fallback, "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=%d",
                 allowed_buffer());
        url = fallback;
    }
    static const char udpm[] = "udpm://";
    static const char memq[] = "memq://";
    const bool is_udpm = strncmp(url, udpm, sizeof udpm - 1) == 0;
    if (!is_udpm && strncmp(url, memq, sizeof memq - 1) != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "LCM url '%.200s': only udpm:// is served (tcpq:// aborts without its "
                          "hub; play a log with softsim-replay); use for example "
                          "udpm://239.255.76.67:7667?ttl=0",
                          url);
        return NULL;
    }
    struct sockaddr_in group;
    if (is_udpm && !read_group(url + sizeof udpm - 1, &group)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "LCM url '%.200s': not a multicast address and port; use for example "
                          "udpm://239.255.76.67:7667?ttl=0",
                          url);
        return NULL;
    }
    if (is_udpm && !has_route(&group)) {
        softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                          "LCM url '%.200s': this machine has no route for multicast; allow it on "
                          "the loopback device with: ip route add 224.0.0.0/4 dev lo",
                          url);
        return NULL;
    }
    lcm_t *lcm = lcm_create(url);
    if (lcm == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                          "LCM url '%.200s': LCM cannot open it; check its options, and that this "
                          "machine has a multicast route (ip route add 224.0.0.0/4 dev lo)",
                          url);
    }
    return lcm;
}

bool ss_wire_check_prefix(const char *prefix, softsim_error *error)
{
    static const char allowed[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.-";
    const size_t length = prefix != NULL ? strnlen(prefix, SS_WIRE_MAX_PREFIX + 1) : 0;
    if (length < 1 || length > SS_WIRE_MAX_PREFIX || strspn(prefix, allowed) != length) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "channel prefix '%.60s': give 1 to %d characters of A-Z a-z 0-9 _ . -",
                          prefix != NULL ? prefix : "", SS_WIRE_MAX_PREFIX);
        return false;
    }
    return true;
}

/* ---- decoding ----------------------------------------------------------------------------- */

/* A bounded reader of LCM's big-endian encoding: once it has run short it stays failed. */
typedef struct reader {
    const uint8_t *at;
    int64_t left;
    bool has_failed;
} reader;

static uint64_t read_unsigned(reader *in, int bytes)
{
    if (in->has_failed || in->left < bytes) {
        in->has_failed = true;
        return 0;
    }
    uint64_t value = 0;
    for (int i = 0; i < bytes; ++i) {
        value = value << 8 | in->at[i];
    }
    in->at += bytes;
    in->left -= bytes;
    return value;
}

static int64_t read_int64(reader *in)
{
    return (int64_t)read_unsigned(in, 8);
}

static int32_t read_int32(reader *in)
{
    return (int32_t)(uint32_t)read_unsigned(in, 4);
}

/* A string is its length, the NUL included, and its bytes. No NUL before the last, no control
 * character, no more than `size` bytes. */
static void read_string(reader *in, char *out_text, int32_t size)
{
    const int32_t length = read_int32(in);
    if (in->has_failed || length < 1 || length > size || length > in->left) {
        in->has_failed = true;
        return;
    }
    for (int32_t i = 0; i < length; ++i) {
        const uint8_t byte = in->at[i];
        const bool is_last = i == length - 1;
        if (is_last != (byte == 0) || (!is_last && (byte < 0x20 || byte == 0x7f))) {
            in->has_failed = true;
            return;
        }
    }
    memcpy(out_text, in->at, (size_t)length);
    in->at += length;
    in->left -= length;
}

softsim_refusal ss_net_decode_pose(const void *data, int64_t size, int64_t receive_ns,
                                   softsim_pose *out_pose)
{
    reader in = {.at = data, .left = size};
    if (size < HASH_SIZE) {
        return SOFTSIM_REFUSED_MALFORMED;
    }
    if (read_int64(&in) != __softsim_probe_pose_t_get_hash()) {
        return SOFTSIM_REFUSED_TYPE_HASH;
    }
    softsim_probe_pose_t wire;
    if (size != POSE_SIZE || softsim_probe_pose_t_decode(data, 0, POSE_SIZE, &wire) != POSE_SIZE) {
        return SOFTSIM_REFUSED_MALFORMED;
    }
    *out_pose = (softsim_pose){.utime_us = wire.utime,
                               .sender = wire.sender,
                               .receive_ns = receive_ns,
                               .seq = wire.seq,
                               .probe = wire.probe,
                               .buttons = wire.buttons,
                               .force_seq = wire.force_seq,
                               .flags = wire.flags};
    ss_copy3(out_pose->position, wire.position);
    memcpy(out_pose->orientation, wire.orientation, sizeof out_pose->orientation);
    ss_copy3(out_pose->velocity, wire.velocity);
    ss_copy3(out_pose->applied_force, wire.applied_force);
    ss_gate_normalize(out_pose);
    return SOFTSIM_ACCEPTED;
}

softsim_refusal ss_net_decode_command(const void *data, int64_t size, ss_net_command *out_command)
{
    reader in = {.at = data, .left = size};
    if (size < HASH_SIZE) {
        return SOFTSIM_REFUSED_MALFORMED;
    }
    if (read_int64(&in) != __softsim_command_t_get_hash()) {
        return SOFTSIM_REFUSED_TYPE_HASH;
    }
    memset(out_command, 0, sizeof *out_command);
    out_command->utime_us = read_int64(&in);
    out_command->sender = read_int64(&in);
    out_command->seq = read_int32(&in);
    out_command->id = read_int32(&in);
    read_string(&in, out_command->name, sizeof out_command->name);
    read_string(&in, out_command->argument, sizeof out_command->argument);
    return in.has_failed || in.left != 0 ? SOFTSIM_REFUSED_MALFORMED : SOFTSIM_ACCEPTED;
}

softsim_refusal ss_net_decode_status(const void *data, int64_t size, int64_t *out_utime_us,
                                     int32_t *out_seq)
{
    reader in = {.at = data, .left = size};
    if (size < HASH_SIZE) {
        return SOFTSIM_REFUSED_MALFORMED;
    }
    if (read_int64(&in) != __softsim_server_status_t_get_hash()) {
        return SOFTSIM_REFUSED_TYPE_HASH;
    }
    *out_utime_us = read_int64(&in);
    *out_seq = read_int32(&in);
    return in.has_failed ? SOFTSIM_REFUSED_MALFORMED : SOFTSIM_ACCEPTED;
}
