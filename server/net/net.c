/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The net thread's side of LCM: probe poses and commands in, forces, status and replies out.
 *
 * Raw subscriptions, one per probe channel, so that a flood on one starves no other; LCM keeps the
 * first messages of a full queue and drops the newest, so everything is drained at each wake and
 * the queues are long enough for a stall of a quarter second at 1 kHz. Messages are encoded into
 * one fixed buffer (the generated publish functions allocate). Nothing here is called by the
 * real-time loops: lcm_publish locks.
 */
#include <errno.h>
#include <poll.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "net/net.h"
#include "net/wire.h"
#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/packets.h"
#include "rt/vec.h"
#include "softsim_command_t.h"
#include "softsim_contact_force_t.h"
#include "softsim_probe_pose_t.h"
#include "softsim_reply_t.h"
#include "softsim_server_status_t.h"

enum {
    QUEUE_LENGTH = 256,
    MAX_DRAIN = 4096,     /* messages a wake, so that status goes out in a flood too */
    STATUS_MEMORY = 1024, /* of our own; more than can wait in the queues at once */
    REPLY_TEXT_SIZE = 8192,
    STATUS_TEXT_SIZE = 1024
};

typedef struct probe_channel {
    ss_net *net;
    int32_t probe;
    char force_channel[SS_WIRE_CHANNEL_SIZE];
} probe_channel;

struct ss_net {
    lcm_t *lcm;
    ss_net_calls calls;
    bool is_lockstep;
    probe_channel probe[SOFTSIM_MAX_PROBES];
    char status_channel[SS_WIRE_CHANNEL_SIZE];
    char reply_channel[SS_WIRE_CHANNEL_SIZE];
    int32_t status_seq;
    int64_t status_utime[STATUS_MEMORY]; /* of the own status seq, by its remainder */
    int32_t reply_seq;
    atomic_int_least64_t dropped; /* statistics: relaxed */
    atomic_int_least64_t foreign;
    char reply_text[REPLY_TEXT_SIZE];
    char status_text[3][STATUS_TEXT_SIZE];
    uint8_t buffer[SS_WIRE_MAX_MESSAGE];
};

static int64_t now_us(void)
{
    return ss_clock_now_ns() / 1000;
}

/* ---- out ---------------------------------------------------------------------------------- */

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
    softsim_contact_force_t wire = {.utime = force->utime_us != 0 ? force->utime_us : now_us(),
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
    ss_copy3(wire.force, force->force);
    ss_copy3(wire.torque, force->torque);
    ss_copy3(wire.model_force, force->model_force);
    ss_copy3(wire.point, force->point);
    ss_copy3(wire.normal, force->normal);
    ss_copy3(wire.proxy, force->proxy);
    const int size = softsim_contact_force_t_encode(net->buffer, 0, sizeof net->buffer, &wire);
    return publish(net, net->probe[force->probe].force_channel, size);
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

/* Message strings may not be NULL, nor of any length. */
static char *bounded_text(ss_net *net, int slot, const char *text)
{
    snprintf(net->status_text[slot], STATUS_TEXT_SIZE, "%s", text != NULL ? text : "");
    return net->status_text[slot];
}

bool ss_net_send_status(ss_net *net, const ss_report *report)
{
    softsim_server_status_t wire = {
        .utime = now_us(),
        .seq = ++net->status_seq,
        .verdict = (int32_t)report->verdict,
        .fault_bits = report->fault_bits,
        .threads = report->threads,
        .nodes = report->nodes,
        .active_nodes = report->active_nodes,
        .elements = report->elements,
        .worst_element = report->worst_element,
        .substeps = report->substeps,
        .probes = report->probes,
        .plan_hash = report->plan_hash,
        .state_hash = report->state_hash,
        .step = report->step,
        .bytes_in_use = report->bytes_in_use,
        .poses_received = report->poses_received,
        .poses_superseded = report->poses_superseded,
        .mesh_bytes_sent = report->mesh_bytes_sent,
        .wire_dropped = report->wire_dropped,
        .uptime_s = report->uptime_s,
        .simulation_rate_hz = report->simulation_rate_hz,
        .stable_step_s = report->stable_step_s,
        .kinetic_j = report->kinetic_j,
        .elastic_j = report->elastic_j,
        .total_j = report->total_j,
        .energy_to_device_j = report->energy_to_device_j,
        .energy_from_device_j = report->energy_from_device_j,
        .stiffness_backoffs = report->stiffness_backoffs,
        .scene = bounded_text(net, 0, report->scene),
        .model = bounded_text(net, 1, report->model),
        .reason = bounded_text(net, 2, report->reason),
    };
    for (int i = 0; i < SOFTSIM_MAX_PROBES; ++i) {
        wire.probe_periods[i] = report->probe_periods[i];
        wire.probe_forces[i] = report->probe_forces[i];
        wire.probe_missed[i] = report->probe_missed[i];
        wire.worst_contact_j[i] = report->worst_contact_j[i];
        wire.stiffness_limit_n_per_m[i] = report->stiffness_limit_n_per_m[i];
    }
    _Static_assert(sizeof wire.poses_refused / sizeof *wire.poses_refused == SOFTSIM_REFUSED_COUNT,
                   "server_status_t.poses_refused");
    for (int i = 0; i < SOFTSIM_REFUSED_COUNT; ++i) {
        wire.poses_refused[i] = report->poses_refused[i];
    }
    ss_copy3(wire.step_us, report->step_us);
    memcpy(wire.lateness_us, report->lateness_us, sizeof wire.lateness_us);
    memcpy(wire.loop_delay_ms, report->loop_delay_ms, sizeof wire.loop_delay_ms);
    net->status_utime[(uint32_t)wire.seq % STATUS_MEMORY] = wire.utime;
    const int size = softsim_server_status_t_encode(net->buffer, 0, sizeof net->buffer, &wire);
    return publish(net, net->status_channel, size);
}

int64_t ss_net_dropped(const ss_net *net)
{
    return atomic_load_explicit(&net->dropped, memory_order_relaxed);
}

int64_t ss_net_foreign(const ss_net *net)
{
    return atomic_load_explicit(&net->foreign, memory_order_relaxed);
}

/* ---- in ----------------------------------------------------------------------------------- */

static void receive_pose(const lcm_recv_buf_t *message, const char *channel, void *user)
{
    (void)channel;
    const probe_channel *probe = user;
    ss_net *net = probe->net;
    const int64_t receive_ns = net->is_lockstep ? 0 : ss_clock_now_ns();
    softsim_pose pose;
    const softsim_refusal refusal =
        ss_net_decode_pose(message->data, message->data_size, receive_ns, &pose);
    if (refusal != SOFTSIM_ACCEPTED) {
        net->calls.handle_refusal(net->calls.context, refusal, probe->probe);
        return;
    }
    net->calls.handle_pose(net->calls.context, &pose, probe->probe, receive_ns);
}

static void receive_command(const lcm_recv_buf_t *message, const char *channel, void *user)
{
    (void)channel;
    ss_net *net = user;
    ss_net_command command;
    const softsim_refusal refusal =
        ss_net_decode_command(message->data, message->data_size, &command);
    if (refusal != SOFTSIM_ACCEPTED) {
        net->calls.handle_refusal(net->calls.context, refusal, -1);
        return;
    }
    net->reply_text[0] = '\0';
    const int32_t code =
        net->calls.handle_command(net->calls.context, command.name, command.argument,
                                  net->reply_text, (int32_t)sizeof net->reply_text);
    net->reply_text[sizeof net->reply_text - 1] = '\0';
    send_reply(net, &command, code);
}

/* Multicast brings our own status back too; any other is another server's. */
static void receive_status(const lcm_recv_buf_t *message, const char *channel, void *user)
{
    (void)channel;
    ss_net *net = user;
    int64_t utime = 0;
    int32_t seq = 0;
    if (ss_net_decode_status(message->data, message->data_size, &utime, &seq) == SOFTSIM_ACCEPTED &&
        net->status_utime[(uint32_t)seq % STATUS_MEMORY] != utime) {
        atomic_fetch_add_explicit(&net->foreign, 1, memory_order_relaxed);
    }
}

bool ss_net_wait(ss_net *net, int wake_fd, int timeout_ms)
{
    /* poll passes over a negative descriptor. */
    struct pollfd waiting[2] = {{.fd = lcm_get_fileno(net->lcm), .events = POLLIN},
                                {.fd = wake_fd, .events = POLLIN}};
    if (poll(waiting, 2, timeout_ms > 0 ? timeout_ms : 0) < 0) {
        return errno == EINTR;
    }
    if ((waiting[1].revents & POLLIN) != 0) {
        ss_wake_drain(wake_fd);
    }
    /* lcm_handle dispatches one message, and would block without one. A signal that comes meanwhile
     * ends the call and stays for the next one: a flood must not keep the forces waiting. */
    bool is_signalled = false;
    for (int i = 0; i < MAX_DRAIN && !is_signalled && (waiting[0].revents & POLLIN) != 0; ++i) {
        if (lcm_handle(net->lcm) != 0 || (poll(waiting, 2, 0) < 0 && errno != EINTR)) {
            return false;
        }
        is_signalled = (waiting[1].revents & POLLIN) != 0;
    }
    return (waiting[0].revents & (POLLERR | POLLHUP | POLLNVAL)) == 0;
}

/* ---- opening ------------------------------------------------------------------------------ */

/* The generated code computes a type's hash on first use, unguarded: do it here, once. */
static void compute_hashes(void)
{
    __softsim_probe_pose_t_get_hash();
    __softsim_command_t_get_hash();
    __softsim_contact_force_t_get_hash();
    __softsim_server_status_t_get_hash();
    __softsim_reply_t_get_hash();
}

/* LCM reads a channel to subscribe to as a regular expression; of our characters only the dot
 * means something in one. */
static void escape(const char *text, char out_regex[2 * SS_WIRE_CHANNEL_SIZE])
{
    for (; *text != '\0'; ++text) {
        if (*text == '.') {
            *out_regex++ = '\\';
        }
        *out_regex++ = *text;
    }
    *out_regex = '\0';
}

static bool subscribe(ss_net *net, const char *channel, lcm_msg_handler_t handler, void *user,
                      softsim_error *error)
{
    char regex[2 * SS_WIRE_CHANNEL_SIZE];
    escape(channel, regex);
    lcm_subscription_t *subscription = lcm_subscribe(net->lcm, regex, handler, user);
    if (subscription == NULL || lcm_subscription_set_queue_capacity(subscription, QUEUE_LENGTH)) {
        softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                          "channel %s: LCM cannot subscribe, its own test message did not come "
                          "back; look for a packet filter on the multicast group and port",
                          channel);
        return false;
    }
    return true;
}

static bool subscribe_all(ss_net *net, const char *prefix, softsim_error *error)
{
    char channel[SS_WIRE_CHANNEL_SIZE];
    ss_packets_mark mark;
    ss_packets_remember(&mark);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        probe_channel *probe = &net->probe[p];
        probe->net = net;
        probe->probe = p;
        snprintf(probe->force_channel, sizeof probe->force_channel, "%s_FORCE_%d", prefix, p);
        snprintf(channel, sizeof channel, "%s_PROBE_%d", prefix, p);
        if (!subscribe(net, channel, receive_pose, probe, error)) {
            return false;
        }
    }
    snprintf(net->status_channel, sizeof net->status_channel, "%s_STATUS", prefix);
    snprintf(net->reply_channel, sizeof net->reply_channel, "%s_REPLY", prefix);
    snprintf(channel, sizeof channel, "%s_COMMAND", prefix);
    if (!subscribe(net, channel, receive_command, net, error) ||
        !subscribe(net, net->status_channel, receive_status, net, error)) {
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

void ss_net_close(ss_net **net)
{
    if (*net == NULL) {
        return;
    }
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
    compute_hashes();
    status = SOFTSIM_ERROR_NETWORK;
    net->lcm = ss_wire_open(config->lcm_url, error);
    if (net->lcm == NULL || !subscribe_all(net, config->prefix, error)) {
        goto fail;
    }
    *out_net = net;
    return SOFTSIM_OK;
fail:
    if (error != NULL && error->status != SOFTSIM_OK) {
        status = error->status;
    }
    ss_net_close(&net);
    return status;
}
