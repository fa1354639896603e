/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A client of softsimd over LCM: sends probe poses, receives the contact forces that answer them
 * and the server's status. Nothing connects: the server may come, go and come again; poses then
 * simply go unanswered.
 *
 * What arrives is checked before it is decoded: exact size, type hash, finite values, and forces
 * only when they answer this client's own sender number and come from one server. Messages are
 * handled by callbacks from softsim_client_wait, every one that is there, up to a hundred a
 * millisecond.
 * Units are those of softsim/types.h: SI and the world frame; times ending in _ns are nanoseconds
 * of the monotonic clock, in _us microseconds. Errors: a status, and in `error`, which is never
 * NULL, what to do about it; nothing is printed. Thread: a client belongs to one thread at a time,
 * and has none of its own; callbacks run in softsim_client_wait, on the caller's thread, and may
 * send. softsim_client_now_ns and _us: any.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/status.h"
#include "softsim/types.h"
#include "softsim/view.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define SOFTSIM_DEFAULT_PREFIX "SOFTSIM"

typedef struct softsim_client_config {
    const char *lcm_url; /* NULL: LCM_DEFAULT_URL, else the local multicast group */
    const char *prefix;  /* of the channels; NULL: SOFTSIM_DEFAULT_PREFIX */
    void *context;       /* handed to the callbacks */
    /* A force that answers this client; receive_ns of the monotonic clock. NULL: none wanted. */
    void (*handle_force)(void *context, const softsim_force *force, int64_t receive_ns);
    bool hears_all; /* the forces that answer other clients too, for who only watches */
    /* The server's status, valid during the call. NULL: none wanted. */
    void (*handle_status)(void *context, const softsim_server_status *status, int64_t receive_ns);
    /* Only of the server whose forces come, once they do; what others send there is no second
     * server. For who exerts forces: statuses come from anybody, forces answer this client. */
    bool follows_forces;
    /* The server's reply to a command of this client: its number, 0 done, 1 refused or 2 unknown
     * or bad, and a text that is valid during the call. NULL: none wanted. */
    void (*handle_reply)(void *context, int32_t id, int32_t code, const char *text);
    /* What a viewer draws, valid during the call; of the server that is listened to. NULL: none
     * wanted. */
    void (*handle_scene)(void *context, const softsim_scene_report *scene);
    void (*handle_topology)(void *context, const softsim_topology_chunk *chunk);
    void (*handle_delta)(void *context, const softsim_mesh_delta *delta);
    void (*handle_field)(void *context, const softsim_mesh_field *field);
    /* The poses of all probes, as they came: values are not checked. NULL: none wanted. */
    void (*handle_pose)(void *context, const softsim_pose *pose, int32_t channel_probe);
    /* Every message that is handed on and every pose, before it is, as it came: for recordings.
     * NULL: none wanted. */
    void (*handle_raw)(void *context, const char *channel, const void *data, int32_t size);
} softsim_client_config;

/* What came in and was not handed on. */
typedef struct softsim_client_counts {
    int64_t malformed; /* wrong size, type or channel, values that are not finite */
    int64_t foreign;   /* forces for other senders */
    int64_t second;    /* messages of a second server on the prefix */
    int64_t unsent;    /* poses that LCM could not send */
} softsim_client_counts;

typedef struct softsim_client softsim_client;

/* Joins the group and subscribes; draws the sender number; may take seconds where a firewall drops
 * what it sends to itself. SOFTSIM_ERROR_ARGUMENT for an invalid URL or prefix, _NETWORK for a
 * machine without a multicast route or a port that another holds, _SYSTEM where LCM cannot be
 * opened, _MEMORY; *out_client is NULL then. */
softsim_status softsim_client_open(const softsim_client_config *config, softsim_client **out_client,
                                   softsim_error *error);
/* Leaves the group and frees; accepts NULL; nulls. Not from a callback. */
void softsim_client_close(softsim_client **client);
/* This client's random number, never 0. */
int64_t softsim_client_sender(const softsim_client *client);
/* Channel names, "SOFTSIM_PROBE_0" and "SOFTSIM_FORCE_0", of probe 0 to SOFTSIM_MAX_PROBES - 1;
 * valid until the client is closed. */
const char *softsim_client_probe_channel(const softsim_client *client, int32_t probe);
const char *softsim_client_force_channel(const softsim_client *client, int32_t probe);
/* Publishes the pose as it is on the channel of `channel_probe`, 0 to SOFTSIM_MAX_PROBES - 1. False
 * when LCM could not send it, which counts as unsent. */
bool softsim_client_send_pose(softsim_client *client, const softsim_pose *pose,
                              int32_t channel_probe);
/* Publishes a command ("set", "haptic.max_force_n=5"; the argument may be ""). Returns its number,
 * from 1; 0 when no server could take it: a name of more than 31 bytes or none, an argument of more
 * than 1023, a control character, or LCM cannot send. */
int32_t softsim_client_send_command(softsim_client *client, const char *name, const char *argument);
/* Handles every message that is there; when there is none, waits for one until `deadline_ns` of
 * the monotonic clock. Returns how many it handled, 0 after the deadline or a signal, -1 when LCM
 * is broken. */
int32_t softsim_client_wait(softsim_client *client, int64_t deadline_ns);
/* Do two servers answer on the prefix, or did they a moment ago? Only the first one's messages are
 * handed on, and no force should be exerted: the hand would feel now one body, now the other. */
bool softsim_client_hears_two(const softsim_client *client);
/* How often the forces or statuses of another server were handed on in the place of the one before,
 * which was silent: it was started again, say. Their body has felt nothing of what was sent before.
 */
int32_t softsim_client_server_changes(const softsim_client *client);
/* Since the client was opened. */
softsim_client_counts softsim_client_read_counts(const softsim_client *client);
/* The monotonic clock, and the microseconds of it that go into `utime`. */
int64_t softsim_client_now_ns(void);
int64_t softsim_client_now_us(void);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
