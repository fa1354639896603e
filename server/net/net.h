/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The only code that sees LCM or a wire type.
 *
 * In: LCM messages (raw, hostile: length, type hash and bounds are checked before decoding).
 * Out: accepted poses into one ring per probe, commands into a ring; forces, replies, status and
 * mesh messages onto the wire. gate.h has the receive checks without any LCM, for headless runs
 * (softsim-run) and lockstep: the same decisions on the same poses.
 */
#include <stdbool.h>
#include <stdint.h>

#include "net/gate.h"
#include "rt/mailbox.h"
#include "rt/ring.h"
#include "rt/thread.h"
#include "softsim/status.h"
#include "softsim/types.h"
#include "softsim/view.h"

/* ---- exchange between the net thread and the loops ---- */

/* net -> haptic, one ring per probe. */
typedef struct ss_pose_record {
    softsim_pose pose;
    uint32_t sender_epoch;
} ss_pose_record;

/* haptic -> net: one per probe and period. */
typedef struct ss_force_record {
    softsim_force force;
    int64_t tick;   /* haptic period it belongs to */
    int64_t due_ns; /* start of that period */
} ss_force_record;

typedef enum ss_command_kind {
    SS_COMMAND_RESET,
    SS_COMMAND_PAUSE,
    SS_COMMAND_RESUME,
    SS_COMMAND_REFRESH,
    SS_COMMAND_SET,
    SS_COMMAND_STATUS,
    SS_COMMAND_SHUTDOWN
} ss_command_kind;

/* A surface to publish, in surface numbering. All arrays are borrowed and outlive the publisher. */
typedef struct ss_publish_mesh {
    int32_t node_count, triangle_count;
    const double (*rest)[3];
    const int32_t (*triangle)[3];
    const int32_t *file_node; /* NULL: surface numbers are the file's; -1: in no file */
    const uint8_t *fixed;     /* not 0: fixed (bit 0 of the message's node_flag) */
    double diagonal;          /* m; scale = diagonal / 16384 */
} ss_publish_mesh;

/* ---- the wire ---- */

/* Decodes a raw message, trusting nothing in it: SOFTSIM_ACCEPTED, or why not (TYPE_HASH,
 * MALFORMED). What is decoded is not judged yet. RT-safe. */
softsim_refusal ss_net_decode_pose(const void *data, int64_t size, int64_t receive_ns,
                                   softsim_pose *out_pose);

typedef struct ss_net_command {
    int64_t utime_us;
    int64_t sender;
    int32_t seq;
    int32_t id;
    char name[32];       /* longer is malformed, as is a control character */
    char argument[1024]; /* the same */
} ss_net_command;
softsim_refusal ss_net_decode_command(const void *data, int64_t size, ss_net_command *out_command);
/* What tells one server from another. */
typedef struct ss_net_status {
    int64_t utime_us;
    int32_t seq;
    double uptime_s;  /* finite, 0 or more */
    char scene[1024]; /* longer is malformed, as is a control character; may be shown */
} ss_net_status;
softsim_refusal ss_net_decode_status(const void *data, int64_t size, ss_net_status *out_status);

/* Did the user name a url, by argument or by LCM_DEFAULT_URL? Thread: set-up only. */
bool ss_net_is_own_url(const char *lcm_url);

typedef struct ss_net_config {
    /* NULL or "": LCM_DEFAULT_URL, else multicast on this host. Only udpm:// and memq:// (one
     * process, for tests) are accepted. */
    const char *lcm_url;
    const char *prefix; /* 1..40 characters of A-Z a-z 0-9 _ . - */
    bool is_lockstep;
} ss_net_config;

/* Called by the net thread. `handle_pose` decides by the gate and pushes (real time) or ticks the
 * world and answers (lockstep); its receive_ns is 0 in lockstep. `handle_refusal` hears of
 * messages that could not be decoded, and of commands beyond their budget (other);
 * `channel_probe` is -1 when it was a command.
 * `handle_command` runs the command and answers by returning the code and filling the text
 * (text_size bytes, empty before); a negative code is no answer. */
typedef struct ss_net_calls {
    void *context;
    void (*handle_pose)(void *context, const softsim_pose *pose, int32_t channel_probe,
                        int64_t receive_ns);
    void (*handle_refusal)(void *context, softsim_refusal reason, int32_t channel_probe);
    int32_t (*handle_command)(void *context, const char *name, const char *argument, char *out_text,
                              int32_t text_size);
} ss_net_calls;

/* Another server on the prefix, by what it says of itself; see other_server.c. */
typedef struct ss_other_server {
    int64_t first_ns, last_ns; /* when it was first and last heard; 0: never */
    ss_net_status status;      /* the newest */
} ss_other_server;
/* Takes a status of another server; of several, the first until it is silent. Thread: net. */
void ss_other_server_hear(ss_other_server *other, const ss_net_status *status, int64_t now_ns);
/* Is it there to stay? One that ends says a last word, and is heard for less than 0.3 s then. */
bool ss_other_server_is_alive(const ss_other_server *other, int64_t now_ns);
/* Was it there before a server that has run for `uptime_s` since `start_us`, by the statuses of
 * both? Of two servers at most one gets a yes, whatever the delay between them. */
bool ss_other_server_is_senior(const ss_other_server *other, double uptime_s, int64_t start_us);

typedef struct ss_net ss_net;

/* Opens LCM and the receiver. On failure the error says what to do. Thread: net. */
softsim_status ss_net_open(const ss_net_config *config, const ss_net_calls *calls, ss_net **out_net,
                           softsim_error *error);
void ss_net_close(ss_net **net);
/* Waits at most `timeout_ms` for a message or a signal on `wake_fd` (-1: none) and handles what is
 * there, as far as the budget of messages goes; with a signal one batch, so that what was signalled
 * is looked for without delay. Drains the signal. False when the network is broken. Thread: net. */
bool ss_net_wait(ss_net *net, int wake_fd, int timeout_ms);
/* Stamps `utime` where the force has none. False (counted in ss_net_dropped) when the message
 * could not be sent. Thread: net. */
bool ss_net_send_force(ss_net *net, const softsim_force *force);
/* Thread: any. */
int64_t ss_net_dropped(const ss_net *net);
/* The server heard on this prefix that is not this one. Thread: net. */
const ss_other_server *ss_net_other_server(const ss_net *net);
/* It has ended: from here on only who is heard again is one. Thread: net. */
void ss_net_forget_other_server(ss_net *net);
/* Sends a command to every other server on the prefix; the own one passes over it. Thread: net. */
void ss_net_send_command(ss_net *net, const char *name);

/* Sets `seq` and utime_us. False (counted in ss_net_dropped) when it does not fit one message or
 * could not be sent. Thread: net. */
bool ss_net_send_scene(ss_net *net, softsim_scene_report *scene);

/* Sets `seq`, and `utime` where it is 0; texts may be NULL and of any length. Thread: net. */
bool ss_net_send_status(ss_net *net, const softsim_server_status *status);

/* ---- mesh publisher: an LCM object and a thread of its own ---- */

typedef struct ss_publisher ss_publisher;
typedef struct ss_publisher_config {
    const char *lcm_url;
    const char *prefix;
    double max_bytes_per_s;
} ss_publisher_config;

softsim_status ss_publisher_open(const ss_publisher_config *config, const ss_publish_mesh *mesh,
                                 ss_publisher **out_publisher, softsim_error *error);
void ss_publisher_close(ss_publisher **publisher);
/* Sends what is due at `now_ns`: topology chunks (every 2 s and after refresh), deltas of the nodes
 * that are off by more than half a count from what was last sent of them, and the rolling refresh
 * (both every 10 s of a surface at rest);
 * at most two messages a call, fields included, so that a default receive buffer holds them: call
 * it at display rate. `displacement`: 3 floats a surface node, NULL when there is no new state
 * (`step` is ignored then). Thread: publish. */
void ss_publisher_send(ss_publisher *publisher, int64_t now_ns, int64_t step,
                       const float *displacement);
/* A scalar a node goes out with the next send, in as many messages as it takes; one that has not
 * changed once a second. What
 * stands for the message's `low` and `high` follows the values: at once where they grow, slowly
 * where they shrink, so that colours do not flicker. Values that are not finite are 0. Thread:
 * publish. */
void ss_publisher_set_field(ss_publisher *publisher, int64_t now_ns, int64_t step, const char *name,
                            const char *unit, const float *value);
/* Is the field to be set though there is no new state? Who comes late has not had it. Thread:
 * publish. */
bool ss_publisher_wants_field(const ss_publisher *publisher);
/* Topology and every displaced node again, from the next send on. Thread: publish. */
void ss_publisher_refresh(ss_publisher *publisher);
/* Bytes of messages in any one second, at least 1000. Thread: publish. */
void ss_publisher_set_max_bytes(ss_publisher *publisher, double max_bytes_per_s);
/* Its number, as the messages name it. Thread: any. */
int32_t ss_publisher_topology(const ss_publisher *publisher);
/* Thread: any. */
int64_t ss_publisher_bytes(const ss_publisher *publisher);    /* of messages, sent since open */
bool ss_publisher_is_clamping(const ss_publisher *publisher); /* displacement beyond the scale */
bool ss_publisher_is_capped(const ss_publisher *publisher);   /* the 2 s or 1 s is not kept */
