/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The net thread's side of LCM: probe poses and commands in, forces, status and replies out.
 *
 * Poses, commands, requests for a status and statuses come in lanes of their own, so that a flood
 * of one starves no other; everything is drained at each wake, as far as the budgets go: together
 * they hold the net thread under a fifth of a core. Those who send commands or requests have fair
 * shares of another budget, since a reply and a status cost what fifty poses do (senders.h); who
 * sends far more than its share is not heard at all for a while (receiver.c).
 * Messages are encoded into one fixed buffer (the generated publish functions allocate). Nothing
 * here is called by the real-time loops: lcm_publish locks.
 */
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "net/codec.h"
#include "net/net.h"
#include "net/receiver.h"
#include "net/senders.h"
#include "net/status_wire.h"
#include "net/view_wire.h"
#include "net/wire.h"
#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/vec.h"
#include "softsim_command_t.h"
#include "softsim_contact_force_t.h"
#include "softsim_probe_pose_t.h"
#include "softsim_reply_t.h"
#include "softsim_scene_t.h"

enum {
    MAX_MESSAGE = 2048,   /* bytes; poses have 148, commands at most 1096 */
    LANE_BUFFER = 212992, /* bytes in the kernel, which doubles it: 554 poses */
    /* Units of work of the receiver: 0.15 ms a millisecond. Twenty poses one by one, or 89 in
     * batches: eight probes at 10 kHz. */
    POSE_WORK_PER_MS = 100,
    POSE_WORK_BURST = 1024,
    COMMAND_WORK_PER_MS = 8,
    REQUEST_WORK_PER_MS = 4,
    STATUS_WORK_PER_MS = 8, /* ours too */
    OTHER_WORK_BURST = 256,
    /* Of one sender, and of all together. */
    COMMANDS_PER_S = 100,
    ALL_COMMANDS_PER_S =
        900,             /* the rings to the loops take a second's and a burst (world/plan.c) */
    REQUESTS_PER_S = 20, /* two servers that start ask for as many */
    ALL_REQUESTS_PER_S = 180,
    MUTED_PER_S = 200,    /* beyond, a sender is muted; no honest one can be made to say as much */
    COMMAND_NAME_AT = 32, /* byte of a message: its length, then its characters and a NUL */
    STATUS_MEMORY = 1024, /* of our own; more than can wait in the queues at once */
    REPLY_TEXT_SIZE = 8192,
    STATUS_TEXT_SIZE = 1024
};

struct ss_net {
    lcm_t *lcm; /* sends */
    ss_receiver *receiver;
    ss_net_calls calls;
    bool is_lockstep;
    ss_senders commands, requests;
    char force_channel[SOFTSIM_MAX_PROBES][SS_WIRE_CHANNEL_SIZE];
    char status_channel[SS_WIRE_CHANNEL_SIZE];
    char reply_channel[SS_WIRE_CHANNEL_SIZE];
    char command_channel[SS_WIRE_CHANNEL_SIZE];
    char scene_channel[SS_WIRE_CHANNEL_SIZE];
    int32_t status_seq;
    int64_t status_utime[STATUS_MEMORY]; /* of the own status seq, by its remainder */
    int32_t reply_seq, scene_seq;
    atomic_int_least64_t dropped; /* statistics: relaxed */
    int64_t sender;               /* of the own commands, which come back too */
    ss_other_server other;
    char reply_text[REPLY_TEXT_SIZE];
    char status_text[3][STATUS_TEXT_SIZE];
    uint8_t buffer[SS_WIRE_MAX_MESSAGE];
};

static int64_t now_us(void)
{
    return ss_clock_now_ns() / 1000;
}

/* ---- out ---- */

/* Sends what was encoded into the buffer; a negative size is an encoder's refusal. */
static bool publish(ss_net *net, const char *channel, int size)
{
    if (size > 0 && lcm_publish(net->lcm, channel, net->buffer, (unsigned)size) == 0) {
        return true;
    }
    atomic_fetch_add_explicit(&net->dropped, 1, memory_order_relaxed);
    return false;
}

bool ss_net_send_force(ss_net *net, const softsim_force *force)
{
    if (force->probe < 0 || force->probe >= SOFTSIM_MAX_PROBES) {
        return publish(net, "", -1);
    }
    softsim_force sent = *force;
    sent.utime_us = sent.utime_us != 0 ? sent.utime_us : now_us();
    ss_wire_encode_force(&sent, net->buffer);
    return publish(net, net->force_channel[force->probe], SS_WIRE_FORCE_SIZE);
}

static void send_reply(ss_net *net, const ss_net_command *command, int32_t code)
{
    const softsim_reply_t wire = {.utime = now_us(),
                                  .sender = command->sender,
                                  .seq = ++net->reply_seq,
                                  .id = command->id,
                                  .code = code,
                                  .text = net->reply_text};
    const int size = softsim_reply_t_encode(net->buffer, 0, sizeof net->buffer, &wire);
    publish(net, net->reply_channel, size);
}

/* Message strings may not be NULL, nor of any length; what a scene's path has in it that is not to
 * be shown would make the status malformed to others. */
static char *bounded_text(ss_net *net, int slot, const char *text)
{
    snprintf(net->status_text[slot], STATUS_TEXT_SIZE, "%s", text != NULL ? text : "");
    ss_plain_clean(net->status_text[slot]);
    return net->status_text[slot];
}

bool ss_net_send_status(ss_net *net, const softsim_server_status *status)
{
    softsim_server_status_t wire;
    ss_status_to_wire(status, &wire);
    wire.utime = status->utime != 0 ? status->utime : now_us();
    wire.seq = ++net->status_seq;
    wire.scene = bounded_text(net, 0, status->scene);
    wire.model = bounded_text(net, 1, status->model);
    wire.reason = bounded_text(net, 2, status->reason);
    net->status_utime[(uint32_t)wire.seq % STATUS_MEMORY] = wire.utime;
    const int size = softsim_server_status_t_encode(net->buffer, 0, sizeof net->buffer, &wire);
    return publish(net, net->status_channel, size);
}

bool ss_net_send_scene(ss_net *net, softsim_scene_report *scene)
{
    scene->utime_us = now_us();
    scene->seq = ++net->scene_seq;
    return publish(net, net->scene_channel,
                   ss_view_encode_scene(scene, net->buffer, sizeof net->buffer));
}

int64_t ss_net_dropped(const ss_net *net)
{
    return atomic_load_explicit(&net->dropped, memory_order_relaxed);
}

const ss_other_server *ss_net_other_server(const ss_net *net)
{
    return &net->other;
}

void ss_net_forget_other_server(ss_net *net)
{
    net->other = (ss_other_server){0};
}

void ss_net_send_command(ss_net *net, const char *name)
{
    char text[32], none[] = "";
    snprintf(text, sizeof text, "%s", name);
    const softsim_command_t wire = {
        .utime = now_us(), .sender = net->sender, .name = text, .argument = none};
    publish(net, net->command_channel,
            softsim_command_t_encode(net->buffer, 0, sizeof net->buffer, &wire));
}

/* ---- in ---- */

static void receive_pose(void *context, const ss_packet *packet)
{
    ss_net *net = context;
    const int64_t receive_ns = net->is_lockstep ? 0 : ss_clock_now_ns();
    softsim_pose pose;
    const softsim_refusal refusal =
        ss_net_decode_pose(packet->data, packet->size, receive_ns, &pose);
    if (refusal != SOFTSIM_ACCEPTED) {
        net->calls.handle_refusal(net->calls.context, refusal, packet->digit);
        return;
    }
    pose.source = packet->source;
    net->calls.handle_pose(net->calls.context, &pose, packet->digit, receive_ns);
}

static void take_command(ss_net *net, const ss_packet *packet, ss_senders *senders)
{
    ss_net_command command;
    softsim_refusal refusal = ss_net_decode_command(packet->data, packet->size, &command);
    if (refusal == SOFTSIM_ACCEPTED &&
        ss_senders_hear(senders, packet->source, ss_clock_now_ns()) != SS_SENDERS_HEARD) {
        refusal = SOFTSIM_REFUSED_OTHER; /* too many to answer */
    }
    if (refusal != SOFTSIM_ACCEPTED) {
        net->calls.handle_refusal(net->calls.context, refusal, -1);
        return;
    }
    if (command.sender == net->sender) {
        return;
    }
    net->reply_text[0] = '\0';
    const int32_t code =
        net->calls.handle_command(net->calls.context, command.name, command.argument,
                                  net->reply_text, (int32_t)sizeof net->reply_text);
    net->reply_text[sizeof net->reply_text - 1] = '\0';
    if (code >= 0) {
        send_reply(net, &command, code);
    }
}

static void receive_command(void *context, const ss_packet *packet)
{
    ss_net *net = context;
    take_command(net, packet, &net->commands);
}

static void receive_request(void *context, const ss_packet *packet)
{
    ss_net *net = context;
    take_command(net, packet, &net->requests);
}

/* Multicast brings our own status back too; any other is another server's. */
static void receive_status(void *context, const ss_packet *packet)
{
    ss_net *net = context;
    ss_net_status status;
    if (ss_net_decode_status(packet->data, packet->size, &status) == SOFTSIM_ACCEPTED &&
        net->status_utime[(uint32_t)status.seq % STATUS_MEMORY] != status.utime_us) {
        ss_other_server_hear(&net->other, &status, ss_clock_now_ns());
    }
}

/* The name of a request for a status, as it is encoded. */
static const char request_name[] = "\0\0\0\7status";

#define LANE(channel, work_per_ms, work_burst, muted_per_s, its_receive)                           \
    .suffix = {channel}, .max_size = MAX_MESSAGE, .buffer = LANE_BUFFER, .per_ms = (work_per_ms),  \
    .burst = (work_burst), .sender_per_s = (muted_per_s), .receive = (its_receive)
#define REQUEST_NAME .at = COMMAND_NAME_AT, .bytes = request_name, .size = sizeof request_name
static const ss_lane lanes[] = {
    {LANE("_PROBE_#", POSE_WORK_PER_MS, POSE_WORK_BURST, 0, receive_pose)},
    {LANE("_COMMAND", COMMAND_WORK_PER_MS, OTHER_WORK_BURST, MUTED_PER_S, receive_command),
     .part = {REQUEST_NAME, .is_unwanted = true}},
    {LANE("_COMMAND", REQUEST_WORK_PER_MS, OTHER_WORK_BURST, MUTED_PER_S, receive_request),
     .part = {REQUEST_NAME}},
    {LANE("_STATUS", STATUS_WORK_PER_MS, OTHER_WORK_BURST, MUTED_PER_S, receive_status)}};

bool ss_net_wait(ss_net *net, int wake_fd, int timeout_ms)
{
    const int64_t wait_ns = timeout_ms > 0 ? timeout_ms * (int64_t)1000000 : 0;
    return ss_receiver_wait(net->receiver, wake_fd, ss_clock_now_ns() + wait_ns) >= 0;
}

/* ---- opening ---- */

/* The generated code computes a type's hash on first use, unguarded: do it here, once. */
static void compute_hashes(void)
{
    __softsim_probe_pose_t_get_hash();
    __softsim_command_t_get_hash();
    __softsim_contact_force_t_get_hash();
    __softsim_server_status_t_get_hash();
    __softsim_reply_t_get_hash();
    __softsim_scene_t_get_hash();
}

static void name_channels(ss_net *net, const char *prefix)
{
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        snprintf(net->force_channel[p], SS_WIRE_CHANNEL_SIZE, "%s_FORCE_%d", prefix, p);
    }
    snprintf(net->status_channel, sizeof net->status_channel, "%s_STATUS", prefix);
    snprintf(net->reply_channel, sizeof net->reply_channel, "%s_REPLY", prefix);
    snprintf(net->command_channel, sizeof net->command_channel, "%s_COMMAND", prefix);
    snprintf(net->scene_channel, sizeof net->scene_channel, "%s_SCENE", prefix);
}

void ss_net_close(ss_net **net)
{
    if (*net == NULL) {
        return;
    }
    ss_receiver_close(&(*net)->receiver);
    if ((*net)->lcm != NULL) {
        lcm_destroy((*net)->lcm);
    }
    ss_memory_free(*net);
    *net = NULL;
}

lcm_t *ss_net_lcm(ss_net *net)
{
    return net->lcm;
}

softsim_status ss_net_open(const ss_net_config *config, const ss_net_calls *calls, ss_net **out_net,
                           softsim_error *error)
{
    softsim_status status = SOFTSIM_ERROR_ARGUMENT;
    ss_net *net = NULL;
    *out_net = NULL;
    if (!ss_wire_check_prefix(config->prefix, error)) {
        return status;
    }
    net = ss_memory_get(1, sizeof *net);
    if (net == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    net->calls = *calls;
    net->is_lockstep = config->is_lockstep;
    net->sender = ss_wire_draw_sender();
    net->commands = ss_senders_make(COMMANDS_PER_S, ALL_COMMANDS_PER_S);
    net->requests = ss_senders_make(REQUESTS_PER_S, ALL_REQUESTS_PER_S);
    compute_hashes();
    name_channels(net, config->prefix);
    net->lcm = ss_wire_open(config->lcm_url, error);
    if (net->lcm != NULL) {
        const ss_receiver_config receiver = {.lcm_url = config->lcm_url,
                                             .lcm = net->lcm,
                                             .prefix = config->prefix,
                                             .lane = lanes,
                                             .lane_count = sizeof lanes / sizeof *lanes,
                                             .context = net};
        status = ss_receiver_open(&receiver, &net->receiver, error);
    } else {
        status = error->status;
    }
    if (status != SOFTSIM_OK) {
        ss_net_close(&net);
        return status;
    }
    *out_net = net;
    return SOFTSIM_OK;
}
