/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What stands between the wire and the browsers: one thread that listens to the server and moves
 * the mouse's probe, and what it has heard, kept for whoever asks.
 *
 *   LCM -> hub thread -> state, under one lock -> frames and texts -> browsers (serve.c)
 *   browsers -> aims and commands, under the lock -> hub thread -> LCM
 *
 * Nothing waits for a browser: a frame is made when one can take it, from the state as it is then.
 *
 * The forces of a probe come a thousand times a second. A browser draws sixty frames; it gets the
 * newest state and a sample (last and greatest force) for each sixtieth of a second that it has
 * not seen, ten seconds at most, which is also what a late one begins with:
 *   forces  u8 4, u8 probe, u16 samples, f32 state[27], f32 sample[samples][4], little-endian;
 * state: flags, position 3, orientation 4 (w x y z), proxy 3, point 3, normal 3, force 3, torque 3,
 * depth, indentation, stiffness, age of the model's result in s; sample: time in s, force, greatest
 * force, indentation. A browser gets the surface before its first forces.
 *
 * Texts are objects of JSON with a "type":
 *   scene      what scene_t has; session
 *   status     status: all that server_status_t has; paused; session
 *   silent     is_silent: for a second no status has come
 *   reply      code, text: to a command of this browser
 *   hand       holder of the mouse's probe (you, another browser, nobody); probe, -1 when nobody;
 *              refused: another program has it; devices: probes that other programs move
 *   recording  is_recording, fault, files, lost: messages that the last one lacks since the disk
 *              was too slow; is_temporary: the files go when softsim-web ends
 * session is another number for each start of a server; with it the surface comes anew, at rest.
 *
 * A recording is an LCM log of all that is heard, poses included: softsim-replay plays it, and
 * recorder.h says how it is written and bounded.
 * Thread: any but the hub's own may call; a call is short.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "body.h"
#include "mouse.h"
#include "softsim/client.h"

typedef struct ss_hub ss_hub;

typedef struct ss_hub_config {
    const char *lcm_url, *prefix; /* as of softsim_client_config */
    const char *record_dir;       /* must exist */
    bool is_temporary;            /* finished recordings are removed at the end */
    void (*wake)(void *context);  /* there is something new; from the hub's thread, at most each
                                     sixtieth of a second, and twice a second in any case */
    void *context;
} ss_hub_config;

/* What one browser has been told. Zero at its start. */
typedef struct ss_hub_view {
    int64_t browser; /* its number, not 0 */
    ss_body_copy body;
    uint64_t scene, status, hand, recording, silence; /* versions, from 1 */
    uint64_t reply;                                   /* of the last reply that was looked at */
    uint64_t sample[SOFTSIM_MAX_PROBES];              /* number of the next one */
} ss_hub_view;

softsim_status ss_hub_open(const ss_hub_config *config, ss_hub **out_hub, softsim_error *error);
/* Ends its thread: it wakes nobody any more. Accepts NULL. */
void ss_hub_stop(ss_hub *hub);
/* Ends the thread and a recording; accepts NULL; nulls. Adds to `error` as ss_recorder_close. */
void ss_hub_close(ss_hub **hub, softsim_error *error);
/* Has LCM failed? */
bool ss_hub_is_broken(const ss_hub *hub);

/* The next message for a browser, to be freed with free(), with `before` bytes of room in front of
 * it; NULL when it has all there is. */
uint8_t *ss_hub_next(ss_hub *hub, ss_hub_view *view, size_t before, size_t *out_size,
                     bool *out_is_text);

/* Sends a command; the reply comes as a text to that browser alone. It is of ours when too many
 * wait or for a shutdown, which is not for whoever looks on. */
void ss_hub_command(ss_hub *hub, const ss_hub_view *view, const char *name, const char *argument);
/* Aims the mouse's probe number `probe`, taking it where nobody holds it. False: another browser
 * does, the aim is bad, or the scene, once there is one, has no such tool. */
bool ss_hub_aim(ss_hub *hub, const ss_hub_view *view, int32_t probe, const ss_mouse_aim *aim);
/* Has this browser the mouse's probe? */
bool ss_hub_is_held_by(ss_hub *hub, const ss_hub_view *view);
/* Lets go of the probe, where this browser holds it. */
void ss_hub_drop(ss_hub *hub, const ss_hub_view *view);
/* Starts or ends a recording. */
void ss_hub_record(ss_hub *hub, bool is_wanted);
/* The path of a finished recording of that name, which must be one of this run; NULL for every
 * other name. */
const char *ss_hub_recording(ss_hub *hub, const char *name);
