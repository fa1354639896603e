/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Raw subscriptions, because generated ones decode before anything can be checked: a length field
 * of a hostile status message would be trusted. LCM keeps the first messages of a full queue and
 * drops the newest, so the queue is made long and always emptied.
 */
#include "softsim/client.h"

#include <errno.h>
#include <lcm/lcm.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "net/wire.h"
#include "rt/clock.h"
#include "rt/packets.h"
#include "rt/vec.h"
#include "softsim/log.h"
#include "softsim_command_t.h"
#include "softsim_reply_t.h"
#include "softsim_server_status_t.h"
#include "wire.h"

enum {
    QUEUE_LENGTH = 2000, /* two seconds of forces at 1 kHz, 216 B each */
    MAX_HANDLED = 4096,  /* messages a call of softsim_client_wait, so that it returns */
    NAME_SIZE = 32,      /* of a command, as the server takes it */
    ARGUMENT_SIZE = 1024
};

struct softsim_client {
    softsim_client_config config;
    lcm_t *lcm;
    int64_t sender;
    softsim_client_counts counts;
    char probe_channel[SOFTSIM_MAX_PROBES][SOFTSIM_LOG_CHANNEL_SIZE];
    char force_channel[SOFTSIM_MAX_PROBES][SOFTSIM_LOG_CHANNEL_SIZE];
    char command_channel[SOFTSIM_LOG_CHANNEL_SIZE];
    int32_t command_id; /* of the last command */
};

int64_t softsim_client_now_ns(void)
{
    return ss_clock_now_ns();
}

int64_t softsim_client_now_us(void)
{
    return ss_clock_now_ns() / 1000;
}

/* ---- receiving ------------------------------------------------------------------------------ */

static bool is_finite_force(const softsim_force *force)
{
    return ss_is_finite(force->force, 3) && ss_is_finite(force->torque, 3) &&
           ss_is_finite(force->model_force, 3) && ss_is_finite(force->point, 3) &&
           ss_is_finite(force->normal, 3) && ss_is_finite(force->proxy, 3) &&
           isfinite(force->depth) && isfinite(force->stiffness);
}

static void receive_force(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    softsim_client *client = context;
    const int64_t now_ns = ss_clock_now_ns();
    softsim_force force;
    const int32_t probe = channel[strlen(channel) - 1] - '0'; /* as subscribed: [0-7] */
    if (buffer->data_size != SS_WIRE_FORCE_SIZE ||
        !softsim_log_decode_force(buffer->data, SS_WIRE_FORCE_SIZE, &force) ||
        force.probe != probe || !is_finite_force(&force)) {
        ++client->counts.malformed;
    } else if (force.sender != client->sender) {
        ++client->counts.foreign;
    } else {
        client->config.handle_force(client->config.context, &force, now_ns);
    }
}

/* Bytes of an encoded status before its three strings, type hash included. */
static size_t status_fixed_size(void)
{
    static char empty[] = "";
    const softsim_server_status_t status = {.scene = empty, .model = empty, .reason = empty};
    return (size_t)softsim_server_status_t_encoded_size(&status) - 3 * (sizeof(int32_t) + 1);
}

/* Do `count` strings from byte `at` on fill the rest of the message exactly, each with its NUL? */
static bool has_good_strings(const uint8_t *data, size_t size, size_t at, int count)
{
    for (int i = 0; i < count; ++i) {
        if (size < at + 4) {
            return false;
        }
        const uint32_t length = (uint32_t)data[at] << 24 | (uint32_t)data[at + 1] << 16 |
                                (uint32_t)data[at + 2] << 8 | data[at + 3];
        at += 4;
        if (length < 1 || length > size - at || data[at + length - 1] != '\0') {
            return false;
        }
        at += length;
    }
    return at == size;
}

static void receive_status(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    (void)channel;
    softsim_client *client = context;
    const int64_t now_ns = ss_clock_now_ns();
    softsim_server_status_t status;
    if (buffer->data_size > SOFTSIM_LOG_MAX_DATA ||
        !has_good_strings(buffer->data, buffer->data_size, status_fixed_size(), 3) ||
        softsim_server_status_t_decode(buffer->data, 0, (int)buffer->data_size, &status) < 0) {
        ++client->counts.malformed;
        return;
    }
    client->config.handle_status(client->config.context, &status, now_ns);
    softsim_server_status_t_decode_cleanup(&status);
}

static void receive_reply(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    (void)channel;
    softsim_client *client = context;
    static char empty[] = "";
    const softsim_reply_t none = {.text = empty};
    const size_t fixed = (size_t)softsim_reply_t_encoded_size(&none) - sizeof(int32_t) - 1;
    softsim_reply_t reply;
    if (buffer->data_size > SOFTSIM_LOG_MAX_DATA ||
        !has_good_strings(buffer->data, buffer->data_size, fixed, 1) ||
        softsim_reply_t_decode(buffer->data, 0, (int)buffer->data_size, &reply) < 0) {
        ++client->counts.malformed;
        return;
    }
    if (reply.sender == client->sender) {
        client->config.handle_reply(client->config.context, reply.id, reply.code, reply.text);
    }
    softsim_reply_t_decode_cleanup(&reply);
}

/* ---- opening -------------------------------------------------------------------------------- */

static int64_t draw_sender(void)
{
    uint64_t number = 0;
    if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number) {
        number = (uint64_t)ss_clock_now_ns() * 0x9E3779B97F4A7C15u;
    }
    number &= INT64_MAX;
    return number != 0 ? (int64_t)number : 1;
}

/* One regular expression, one queue. False when LCM refuses. */
static bool subscribe(softsim_client *client, const char *pattern, lcm_msg_handler_t handler)
{
    lcm_subscription_t *subscription = lcm_subscribe(client->lcm, pattern, handler, client);
    return subscription != NULL &&
           lcm_subscription_set_queue_capacity(subscription, QUEUE_LENGTH) == 0;
}

/* LCM reads a channel to subscribe to as a regular expression; of a prefix's characters only the
 * dot means something in one. */
static void escape(const char *prefix, char out_regex[2 * SS_WIRE_MAX_PREFIX + 1])
{
    for (; *prefix != '\0'; ++prefix) {
        if (*prefix == '.') {
            *out_regex++ = '\\';
        }
        *out_regex++ = *prefix;
    }
    *out_regex = '\0';
}

static bool join(softsim_client *client, const char *prefix, softsim_error *error)
{
    char escaped[2 * SS_WIRE_MAX_PREFIX + 1];
    char pattern[sizeof escaped + 16];
    escape(prefix, escaped);
    client->lcm = ss_wire_open(client->config.lcm_url, error);
    if (client->lcm == NULL) {
        return false;
    }
    ss_packets_mark mark;
    ss_packets_remember(&mark);
    bool is_good = true;
    if (client->config.handle_force != NULL) {
        snprintf(pattern, sizeof pattern, "%s_FORCE_[0-7]", escaped);
        is_good = subscribe(client, pattern, receive_force);
    }
    if (is_good && client->config.handle_status != NULL) {
        snprintf(pattern, sizeof pattern, "%s_STATUS", escaped);
        is_good = subscribe(client, pattern, receive_status);
    }
    if (is_good && client->config.handle_reply != NULL) {
        snprintf(pattern, sizeof pattern, "%s_REPLY", escaped);
        is_good = subscribe(client, pattern, receive_reply);
    }
    if (!is_good) {
        softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                          "LCM hears none of its own packets: a firewall drops multicast; allow "
                          "UDP to 239.255.76.67 port 7667, or give another --lcm-url");
        return false;
    }
    if (ss_packets_refuse_fragments(&mark) < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                          "the kernel takes no packet filter, without which one fragment can crash "
                          "LCM; allow SO_ATTACH_FILTER");
        return false;
    }
    return true;
}

softsim_status softsim_client_open(const softsim_client_config *config, softsim_client **out_client,
                                   softsim_error *error)
{
    *out_client = NULL;
    const char *prefix = config->prefix != NULL ? config->prefix : SOFTSIM_DEFAULT_PREFIX;
    if (!ss_wire_check_prefix(prefix, error)) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    softsim_client *client = calloc(1, sizeof *client);
    if (client == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory");
        return SOFTSIM_ERROR_MEMORY;
    }
    client->config = *config;
    client->sender = draw_sender();
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        snprintf(client->probe_channel[p], SOFTSIM_LOG_CHANNEL_SIZE, "%s_PROBE_%d", prefix, p);
        snprintf(client->force_channel[p], SOFTSIM_LOG_CHANNEL_SIZE, "%s_FORCE_%d", prefix, p);
    }
    snprintf(client->command_channel, SOFTSIM_LOG_CHANNEL_SIZE, "%s_COMMAND", prefix);
    if (!join(client, prefix, error)) {
        softsim_client_close(&client);
        return error->status;
    }
    *out_client = client;
    return SOFTSIM_OK;
}

void softsim_client_close(softsim_client **client)
{
    if (*client != NULL) {
        if ((*client)->lcm != NULL) {
            lcm_destroy((*client)->lcm);
        }
        free(*client);
        *client = NULL;
    }
}

/* ---- using ---------------------------------------------------------------------------------- */

int64_t softsim_client_sender(const softsim_client *client)
{
    return client->sender;
}

const char *softsim_client_probe_channel(const softsim_client *client, int32_t probe)
{
    return client->probe_channel[probe];
}

const char *softsim_client_force_channel(const softsim_client *client, int32_t probe)
{
    return client->force_channel[probe];
}

bool softsim_client_send_pose(softsim_client *client, const softsim_pose *pose,
                              int32_t channel_probe)
{
    uint8_t data[SS_WIRE_POSE_SIZE];
    ss_wire_encode_pose(pose, data);
    if (lcm_publish(client->lcm, client->probe_channel[channel_probe], data, sizeof data) != 0) {
        ++client->counts.unsent;
        return false;
    }
    return true;
}

/* The text in `out`, if it fits and holds no control character. */
static bool copy_plain(const char *text, char *out, size_t size)
{
    if (strlen(text) >= size) {
        return false;
    }
    for (const unsigned char *at = (const unsigned char *)text; *at != '\0'; ++at) {
        if (*at < 0x20 || *at == 0x7F) {
            return false;
        }
    }
    strcpy(out, text);
    return true;
}

int32_t softsim_client_send_command(softsim_client *client, const char *name, const char *argument)
{
    char name_copy[NAME_SIZE], argument_copy[ARGUMENT_SIZE];
    if (name[0] == '\0' || !copy_plain(name, name_copy, sizeof name_copy) ||
        !copy_plain(argument, argument_copy, sizeof argument_copy)) {
        return 0;
    }
    const softsim_command_t command = {.utime = softsim_client_now_us(),
                                       .sender = client->sender,
                                       .seq = client->command_id + 1,
                                       .id = client->command_id + 1,
                                       .name = name_copy,
                                       .argument = argument_copy};
    if (softsim_command_t_publish(client->lcm, client->command_channel, &command) != 0) {
        return 0;
    }
    return ++client->command_id;
}

int32_t softsim_client_wait(softsim_client *client, int64_t deadline_ns)
{
    struct pollfd ready = {.fd = lcm_get_fileno(client->lcm), .events = POLLIN};
    int32_t handled = 0;
    while (handled < MAX_HANDLED) {
        int64_t rest_ns = handled > 0 ? 0 : deadline_ns - ss_clock_now_ns();
        rest_ns = rest_ns > 0 ? rest_ns : 0;
        const struct timespec timeout = {.tv_sec = (time_t)(rest_ns / 1000000000),
                                         .tv_nsec = (long)(rest_ns % 1000000000)};
        const int result = ppoll(&ready, 1, &timeout, NULL);
        if (result < 0) {
            return errno == EINTR ? handled : -1;
        }
        if (result == 0) {
            return handled;
        }
        if (lcm_handle(client->lcm) != 0) {
            return -1;
        }
        ++handled;
    }
    return handled;
}

softsim_client_counts softsim_client_read_counts(const softsim_client *client)
{
    return client->counts;
}
