/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Messages are checked before anything is decoded: a generated decoder would trust a length field
 * of a hostile status. They come by the receiver that the server has (server/net/receiver.c);
 * poses and commands go out by LCM.
 */
#include "softsim/client.h"

#include <lcm/lcm.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "net/codec.h"
#include "net/receiver.h"
#include "net/status_wire.h"
#include "net/view_wire.h"
#include "net/wire.h"
#include "origin.h"
#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/vec.h"
#include "softsim/log.h"
#include "softsim_command_t.h"
#include "softsim_contact_force_t.h"
#include "softsim_reply_t.h"

enum {
    MAX_MESSAGE = 16384,    /* bytes, more than any status or reply has */
    LANE_BUFFER = 2097152,  /* bytes, where the kernel allows: five seconds of forces at 1 kHz */
    VIEW_WORK_PER_MS = 100, /* the receiver's units: 89 forces or poses in batches */
    VIEW_WORK_BURST = 4096,
    OTHER_WORK_PER_MS = 10, /* statuses; replies */
    OTHER_WORK_BURST = 256,
    /* Of one sender; a server sends 20 at most, however often it is asked. Beyond it is muted, so
     * that the server that was heard first is heard on. */
    STATUSES_PER_S = 200,
    FORCES_PER_S = 10000, /* likewise: eight probes at 1 kHz, and a fourth more */
    NAME_SIZE = 32,       /* of a command, as the server takes it */
    ARGUMENT_SIZE = 1024
};

/* A server is gone: no restart is as quick as the first, statuses come every 250 ms. */
static const int64_t FORCE_SILENT_NS = 100000000;
static const int64_t STATUS_SILENT_NS = 1000000000;

struct softsim_client {
    softsim_client_config config;
    lcm_t *lcm; /* sends */
    ss_receiver *receiver;
    int64_t sender;
    softsim_client_counts counts;
    ss_origin force_origin, status_origin;
    char probe_channel[SOFTSIM_MAX_PROBES][SOFTSIM_LOG_CHANNEL_SIZE];
    char force_channel[SOFTSIM_MAX_PROBES][SOFTSIM_LOG_CHANNEL_SIZE];
    char command_channel[SOFTSIM_LOG_CHANNEL_SIZE];
    int32_t command_id; /* of the last command */
    ss_view_room room;  /* of the message that is being handed on */
};

int64_t softsim_client_now_ns(void)
{
    return ss_clock_now_ns();
}

int64_t softsim_client_now_us(void)
{
    return ss_clock_now_ns() / 1000;
}

/* ---- receiving ---- */

static void hand_on_raw(const softsim_client *client, const ss_packet *packet)
{
    if (client->config.handle_raw != NULL) {
        client->config.handle_raw(client->config.context, packet->channel, packet->data,
                                  packet->size);
    }
}

static bool is_finite_force(const softsim_force *force)
{
    return ss_is_finite(force->force, 3) && ss_is_finite(force->torque, 3) &&
           ss_is_finite(force->model_force, 3) && ss_is_finite(force->point, 3) &&
           ss_is_finite(force->normal, 3) && ss_is_finite(force->proxy, 3) &&
           isfinite(force->depth) && isfinite(force->stiffness);
}

static void receive_force(void *context, const ss_packet *packet)
{
    softsim_client *client = context;
    const int64_t now_ns = ss_clock_now_ns();
    softsim_force force;
    if (!softsim_log_decode_force(packet->data, packet->size, &force) ||
        force.probe != packet->digit || !is_finite_force(&force)) {
        ++client->counts.malformed;
    } else if (force.sender != client->sender && !client->config.hears_all) {
        ++client->counts.foreign;
    } else if (!ss_origin_take(&client->force_origin, packet->source, now_ns)) {
        ++client->counts.second;
    } else {
        hand_on_raw(client, packet);
        client->config.handle_force(client->config.context, &force, now_ns);
    }
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

static void receive_status(void *context, const ss_packet *packet)
{
    softsim_client *client = context;
    const int64_t now_ns = ss_clock_now_ns();
    softsim_server_status_t status;
    if (client->config.follows_forces && !ss_origin_allows(&client->force_origin, packet->source)) {
        return;
    }
    if (!has_good_strings(packet->data, (size_t)packet->size, (size_t)ss_status_texts_at, 3) ||
        softsim_server_status_t_decode(packet->data, 0, packet->size, &status) < 0) {
        ++client->counts.malformed;
        return;
    }
    if (client->config.follows_forces ||
        ss_origin_take(&client->status_origin, packet->source, now_ns)) {
        softsim_server_status report;
        hand_on_raw(client, packet);
        ss_status_from_wire(&status, &report);
        client->config.handle_status(client->config.context, &report, now_ns);
    } else {
        ++client->counts.second;
    }
    softsim_server_status_t_decode_cleanup(&status);
}

static void receive_reply(void *context, const ss_packet *packet)
{
    softsim_client *client = context;
    static char empty[] = "";
    const softsim_reply_t none = {.text = empty};
    const size_t fixed = (size_t)softsim_reply_t_encoded_size(&none) - sizeof(int32_t) - 1;
    softsim_reply_t reply;
    if (!has_good_strings(packet->data, (size_t)packet->size, fixed, 1) ||
        softsim_reply_t_decode(packet->data, 0, packet->size, &reply) < 0) {
        ++client->counts.malformed;
        return;
    }
    if (reply.sender == client->sender) {
        client->config.handle_reply(client->config.context, reply.id, reply.code, reply.text);
    }
    softsim_reply_t_decode_cleanup(&reply);
}

/* Is a viewer's message, decoded or not, to be handed on? Whoever sent it: the mesh comes from a
 * port of its own. */
static bool is_viewed(softsim_client *client, const ss_packet *packet, bool is_good)
{
    client->counts.malformed += is_good ? 0 : 1;
    if (is_good) {
        hand_on_raw(client, packet);
    }
    return is_good;
}

#define RECEIVE(name, type)                                                                        \
    static void receive_##name(void *context, const ss_packet *packet)                             \
    {                                                                                              \
        softsim_client *client = context;                                                          \
        type message;                                                                              \
        if (is_viewed(                                                                             \
                client, packet,                                                                    \
                ss_view_decode_##name(packet->data, packet->size, &client->room, &message))) {     \
            client->config.handle_##name(client->config.context, &message);                        \
        }                                                                                          \
    }
RECEIVE(topology, softsim_topology_chunk)
RECEIVE(delta, softsim_mesh_delta)
RECEIVE(field, softsim_mesh_field)

/* The server sends it from where its statuses and forces come, the statuses as long as it lives. */
static void receive_scene(void *context, const ss_packet *packet)
{
    softsim_client *client = context;
    const ss_origin *origin = client->config.handle_status != NULL && !client->config.follows_forces
                                  ? &client->status_origin
                                  : &client->force_origin;
    softsim_scene_report scene;
    const bool is_good = ss_view_decode_scene(packet->data, packet->size, &client->room, &scene);
    if (is_good && !ss_origin_allows(origin, packet->source)) {
        ++client->counts.second;
    } else if (is_viewed(client, packet, is_good)) {
        client->config.handle_scene(client->config.context, &scene);
    }
}

static void receive_pose(void *context, const ss_packet *packet)
{
    softsim_client *client = context;
    softsim_pose pose;
    if (is_viewed(client, packet, ss_wire_decode_pose(packet->data, packet->size, &pose))) {
        client->config.handle_pose(client->config.context, &pose, packet->digit);
    }
}

/* ---- opening ---- */

/* Of poses and of the mesh: one of a hundred thousand nodes a few times a second. */
static ss_lane view_lane(void)
{
    return (ss_lane){.max_size = SS_WIRE_MAX_MESSAGE,
                     .buffer = LANE_BUFFER,
                     .per_ms = VIEW_WORK_PER_MS,
                     .burst = VIEW_WORK_BURST};
}

/* All forces have one size: what others send beside the server's, large or many, does not come
 * between it and the hand. */
static ss_lane force_lane(const softsim_client *client)
{
    const softsim_contact_force_t any = {0};
    ss_lane lane = view_lane();
    lane.max_size = softsim_contact_force_t_encoded_size(&any);
    lane.sender_per_s = FORCES_PER_S;
    lane.followed = &client->force_origin.first.source;
    return lane;
}

static ss_lane narrow_lane(int32_t sender_per_s, const uint64_t *followed)
{
    return (ss_lane){.max_size = MAX_MESSAGE,
                     .buffer = LANE_BUFFER,
                     .per_ms = OTHER_WORK_PER_MS,
                     .burst = OTHER_WORK_BURST,
                     .sender_per_s = sender_per_s,
                     .followed = followed};
}

static softsim_status join(softsim_client *client, const char *prefix, softsim_error *error)
{
    client->lcm = ss_wire_open(client->config.lcm_url, error);
    if (client->lcm == NULL) {
        return error->status;
    }
    const softsim_client_config *config = &client->config;
    ss_lane lanes[SS_RECEIVER_MAX_LANES]; /* of what is wanted */
    int32_t count = 0;
    const ss_lane force = force_lane(client), reply = narrow_lane(0, NULL),
                  status = narrow_lane(STATUSES_PER_S, config->follows_forces
                                                           ? &client->force_origin.first.source
                                                           : &client->status_origin.first.source),
                  view = view_lane();
    const struct {
        bool is_wanted;
        const ss_lane *lane;
        const char *suffix;
        void (*receive)(void *, const ss_packet *);
    } rows[] = {{config->handle_force != NULL, &force, "_FORCE_#", receive_force},
                {config->handle_status != NULL, &status, "_STATUS", receive_status},
                {config->handle_reply != NULL, &reply, "_REPLY", receive_reply},
                {config->handle_scene != NULL, &view, "_SCENE", receive_scene},
                {config->handle_topology != NULL, &view, "_MESH_TOPOLOGY", receive_topology},
                {config->handle_delta != NULL, &view, "_MESH_DELTA", receive_delta},
                {config->handle_field != NULL, &view, "_MESH_FIELD", receive_field},
                {config->handle_pose != NULL, &view, "_PROBE_#", receive_pose}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        if (rows[i].is_wanted) {
            lanes[count] = *rows[i].lane;
            lanes[count].suffix[0] = rows[i].suffix;
            lanes[count++].receive = rows[i].receive;
        }
    }
    const ss_receiver_config receiver = {.lcm_url = client->config.lcm_url,
                                         .lcm = client->lcm,
                                         .prefix = prefix,
                                         .lane = lanes,
                                         .lane_count = count,
                                         .context = client};
    return ss_receiver_open(&receiver, &client->receiver, error);
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
        return ss_memory_fault(error);
    }
    client->config = *config;
    client->sender = ss_wire_draw_sender();
    client->force_origin.silent_ns = FORCE_SILENT_NS;
    client->status_origin.silent_ns = STATUS_SILENT_NS;
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        snprintf(client->probe_channel[p], SOFTSIM_LOG_CHANNEL_SIZE, "%s_PROBE_%d", prefix, p);
        snprintf(client->force_channel[p], SOFTSIM_LOG_CHANNEL_SIZE, "%s_FORCE_%d", prefix, p);
    }
    snprintf(client->command_channel, SOFTSIM_LOG_CHANNEL_SIZE, "%s_COMMAND", prefix);
    const softsim_status status = join(client, prefix, error);
    if (status != SOFTSIM_OK) {
        softsim_client_close(&client);
        return status;
    }
    *out_client = client;
    return SOFTSIM_OK;
}

void softsim_client_close(softsim_client **client)
{
    if (*client != NULL) {
        ss_receiver_close(&(*client)->receiver);
        if ((*client)->lcm != NULL) {
            lcm_destroy((*client)->lcm);
        }
        free(*client);
        *client = NULL;
    }
}

/* ---- using ---- */

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
    return ss_receiver_wait(client->receiver, -1, deadline_ns);
}

bool softsim_client_hears_two(const softsim_client *client)
{
    const int64_t now_ns = ss_clock_now_ns();
    return ss_origin_hears_two(&client->force_origin, now_ns) ||
           ss_origin_hears_two(&client->status_origin, now_ns);
}

int32_t softsim_client_server_changes(const softsim_client *client)
{
    const int32_t of_forces = client->force_origin.changes;
    const int32_t of_statuses = client->status_origin.changes;
    return of_forces > of_statuses ? of_forces : of_statuses;
}

softsim_client_counts softsim_client_read_counts(const softsim_client *client)
{
    return client->counts;
}
