/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * LCM opened with care, and raw messages decoded with none of its trust.
 *
 * LCM 1.3.1 needs looking after: tcpq:// without its hub aborts the process at the first wait,
 * a missing multicast route is told by four lines of which one reads freed memory, and a ttl that
 * is no number of 0 to 255 is cut to one that is. So the url is read here first, and LCM is given
 * one that is written again. LCM sends; what is received comes by receiver.c.
 * Generated decoders trust length fields (a 40-byte message can overflow the heap): poses are of
 * one exact size and decoded by the generated code after that was checked (codec.c); commands,
 * which hold strings, are read by the bounded reader.
 */
#include "net/wire.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include "net/codec.h"
#include "net/gate.h"
#include "net/reader.h"
#include "net/status_wire.h"
#include "rt/clock.h"
#include "rt/files.h"
#include "rt/plain.h"
#include "softsim_command_t.h"
#include "softsim_probe_pose_t.h"

enum {
    LCM_FILES = 8, /* that LCM opens at most: sockets and pipes */
    HASH_SIZE = 8
};
static const double MAX_UPTIME = 1e10; /* s: its microseconds are a number of 64 bits */

/* ---- opening ---- */

/* Digits alone, within limits; LCM itself reads -1 and 999999999999 as a ttl of 255. */
static bool read_count(const char *text, int least, int most, int *out_value)
{
    const size_t length = strlen(text);
    if (length < 1 || length > 9 || strspn(text, "0123456789") != length) {
        return false;
    }
    *out_value = atoi(text);
    return *out_value >= least && *out_value <= most;
}

/* ADDRESS[:PORT]; a part left out is LCM's own default. Changes `text`. */
static bool read_group(char *text, struct sockaddr_in *out_group)
{
    int port = 7667;
    char *colon = strchr(text, ':');
    if (colon != NULL) {
        *colon = '\0';
        if (!read_count(colon + 1, 1, 65535, &port)) {
            return false;
        }
    }
    *out_group = (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    const char *address = text[0] != '\0' ? text : "239.255.76.67";
    return inet_pton(AF_INET, address, &out_group->sin_addr) == 1 &&
           IN_MULTICAST(ntohl(out_group->sin_addr.s_addr));
}

/* NAME=VALUE&NAME=VALUE. Changes `text`. NULL, or what is wrong. */
static const char *read_options(char *text, ss_wire_url *url)
{
    char *rest = NULL;
    for (char *option = strtok_r(text, "&", &rest); option != NULL;
         option = strtok_r(NULL, "&", &rest)) {
        static const char ttl[] = "ttl=", buffer[] = "recv_buf_size=";
        if (strncmp(option, ttl, sizeof ttl - 1) == 0) {
            if (!read_count(option + sizeof ttl - 1, 0, 255, &url->ttl)) {
                return "ttl is a whole number from 0, this host only, to 255";
            }
        } else if (strncmp(option, buffer, sizeof buffer - 1) == 0) {
            if (!read_count(option + sizeof buffer - 1, 4096, 1 << 29, &url->buffer)) {
                return "recv_buf_size is a whole number of bytes from 4096 to 536870912";
            }
        } else {
            return "its options are ttl and recv_buf_size";
        }
    }
    return NULL;
}

/* The url that holds: the argument, LCM's environment variable, or "" for neither. */
static const char *choose_url(const char *lcm_url)
{
    const char *url = lcm_url;
    if (url == NULL || url[0] == '\0') {
        url = getenv("LCM_DEFAULT_URL");
    }
    return url != NULL ? url : "";
}

bool ss_net_is_own_url(const char *lcm_url)
{
    return choose_url(lcm_url)[0] != '\0';
}

bool ss_wire_read_url(const char *lcm_url, ss_wire_url *out_url, softsim_error *error)
{
    static const char udpm[] = "udpm://", memq[] = "memq://";
    const char *url = choose_url(lcm_url);
    url = url[0] != '\0' ? url : udpm;
    *out_url = (ss_wire_url){.is_memq = strncmp(url, memq, sizeof memq - 1) == 0};
    if (out_url->is_memq) {
        return true;
    }
    const char *fault = NULL;
    char text[128] = "";
    if (strncmp(url, udpm, sizeof udpm - 1) != 0) {
        fault = "only udpm:// is served (tcpq:// aborts without its hub; play a log with "
                "softsim-replay)";
    } else if (snprintf(text, sizeof text, "%s", url + sizeof udpm - 1) >= (int)sizeof text) {
        fault = "longer than any multicast address and port with options";
    } else {
        char *options = strchr(text, '?');
        if (options != NULL) {
            *options++ = '\0';
        }
        fault = read_group(text, &out_url->group) ? NULL : "not a multicast address and port";
        if (fault == NULL && options != NULL) {
            fault = read_options(options, out_url);
        }
    }
    if (fault != NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "LCM url '%.200s': %s; use for example "
                          "udpm://239.255.76.67:7667?ttl=0",
                          url, fault);
    }
    return fault == NULL;
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
    ss_wire_url url;
    char address[INET_ADDRSTRLEN] = "", text[96] = "memq://";
    if (!ss_wire_read_url(lcm_url, &url, error)) {
        return NULL;
    }
    if (!ss_files_have_room(LCM_FILES)) { /* LCM blames the route then */
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "cannot open LCM: %s",
                          ss_files_reason(EMFILE));
        return NULL;
    }
    if (!url.is_memq) {
        inet_ntop(AF_INET, &url.group.sin_addr, address, sizeof address);
        snprintf(text, sizeof text, "udpm://%s:%d?ttl=%d", address, ntohs(url.group.sin_port),
                 url.ttl);
        if (!has_route(&url.group)) {
            softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                              "LCM url '%s': this machine has no route for multicast; allow it on "
                              "the loopback device with: ip route add 224.0.0.0/4 dev lo",
                              text);
            return NULL;
        }
    }
    lcm_t *lcm = lcm_create(text);
    if (lcm == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                          "LCM url '%s': LCM cannot open it; check that this machine has a "
                          "multicast route (ip route add 224.0.0.0/4 dev lo)",
                          text);
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

int64_t ss_wire_draw_sender(void)
{
    uint64_t number = 0;
    if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number) {
        number = (uint64_t)ss_clock_now_ns() * 0x9E3779B97F4A7C15u;
    }
    number &= INT64_MAX;
    return number != 0 ? (int64_t)number : 1;
}

/* ---- decoding ---- */

/* The type's hash first; MALFORMED and TYPE_HASH where it is not there or another. */
static softsim_refusal begin(ss_reader *out, const void *data, int64_t size, int64_t hash)
{
    *out = (ss_reader){.at = data, .left = size};
    if (size < HASH_SIZE) {
        return SOFTSIM_REFUSED_MALFORMED;
    }
    return ss_read_int64(out) == hash ? SOFTSIM_ACCEPTED : SOFTSIM_REFUSED_TYPE_HASH;
}

/* A string is its length, the NUL included, and its bytes. No NUL before the last, no control
 * character of ASCII, no more than `size` bytes. What else is not to be shown is not taken over. */
static void read_string(ss_reader *in, char *out_text, int32_t size)
{
    const int32_t length = ss_read_int32(in);
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
    ss_plain_clean(out_text);
    in->at += length;
    in->left -= length;
}

softsim_refusal ss_net_decode_pose(const void *data, int64_t size, int64_t receive_ns,
                                   softsim_pose *out_pose)
{
    ss_reader in;
    const softsim_refusal refusal = begin(&in, data, size, __softsim_probe_pose_t_get_hash());
    if (refusal != SOFTSIM_ACCEPTED) {
        return refusal;
    }
    if (!ss_wire_decode_pose(data, size, out_pose)) {
        return SOFTSIM_REFUSED_MALFORMED;
    }
    out_pose->receive_ns = receive_ns;
    ss_gate_normalize(out_pose);
    return SOFTSIM_ACCEPTED;
}

softsim_refusal ss_net_decode_command(const void *data, int64_t size, ss_net_command *out_command)
{
    ss_reader in;
    const softsim_refusal refusal = begin(&in, data, size, __softsim_command_t_get_hash());
    if (refusal != SOFTSIM_ACCEPTED) {
        return refusal;
    }
    memset(out_command, 0, sizeof *out_command);
    out_command->utime_us = ss_read_int64(&in);
    out_command->sender = ss_read_int64(&in);
    out_command->seq = ss_read_int32(&in);
    out_command->id = ss_read_int32(&in);
    read_string(&in, out_command->name, sizeof out_command->name);
    read_string(&in, out_command->argument, sizeof out_command->argument);
    return in.has_failed || in.left != 0 ? SOFTSIM_REFUSED_MALFORMED : SOFTSIM_ACCEPTED;
}

/* On to byte `at` of a message of `size` bytes. */
static void skip_to(ss_reader *in, int64_t size, int64_t at)
{
    const int64_t bytes = at - (size - in->left);
    in->has_failed = in->has_failed || in->left < bytes;
    in->at += in->has_failed ? 0 : bytes;
    in->left -= in->has_failed ? 0 : bytes;
}

softsim_refusal ss_net_decode_status(const void *data, int64_t size, ss_net_status *out_status)
{
    ss_reader in;
    const softsim_refusal refusal = begin(&in, data, size, __softsim_server_status_t_get_hash());
    if (refusal != SOFTSIM_ACCEPTED) {
        return refusal;
    }
    memset(out_status, 0, sizeof *out_status);
    out_status->utime_us = ss_read_int64(&in);
    out_status->seq = ss_read_int32(&in);
    skip_to(&in, size, ss_status_uptime_at);
    out_status->uptime_s = ss_read_double(&in);
    skip_to(&in, size, ss_status_texts_at);
    read_string(&in, out_status->scene, sizeof out_status->scene);
    return in.has_failed || !(out_status->uptime_s >= 0.0 && out_status->uptime_s < MAX_UPTIME)
               ? SOFTSIM_REFUSED_MALFORMED
               : SOFTSIM_ACCEPTED;
}
