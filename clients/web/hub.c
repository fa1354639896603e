/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "hub.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "indentation.h"
#include "page_json.h"
#include "parameter.h"
#include "process.h"
#include "recorder.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/vec.h"

enum {
    SAMPLES = 640, /* ten seconds, of FRAME_NS each */
    STATE_FLOATS = 27,
    COMMANDS = 64, /* that wait to be sent */
    ASKED = 1024,  /* that may wait for a reply; of more the oldest get none */
    REPLIES = 64,
    MESH_ASKS = 5,
    RECORDINGS = 256,
    RECORDER_ROOM = 1 << 25 /* bytes: seconds of all that a busy server says */
};
static const int64_t FRAME_NS = 16000000;
static const int64_t HEARTBEAT_NS = 500000000;
static const int64_t POSE_NS = 4000000;
static const int64_t IDLE_NS = 20000000;
static const int64_t SILENT_NS = 1000000000; /* without a status, of four a second: no server */
static const int64_t MESH_ASK_NS = 2000000000;
static const int64_t DEVICE_NS = 500000000; /* as long as a server keeps a probe for it */
static const int64_t FORCE_SILENT_NS = 500000000;
static const int64_t MOST_RECORDED = INT64_C(4000000000);         /* bytes of one recording */
static const int64_t MOST_RECORDED_IN_ALL = INT64_C(16000000000); /* of all of a run */

typedef struct sample {
    float time_s, force, peak, indentation;
} sample;

typedef struct probe_state {
    softsim_force force;
    softsim_pose pose;
    bool has_pose;
    ss_indentation indentation;
    int64_t heard_ns, sample_ns;
    sample open; /* being filled: 16 ms */
    sample ring[SAMPLES];
    uint64_t count; /* of samples, ever */
} probe_state;

typedef struct command {
    int64_t browser;
    char name[32], argument[512];
} command;

/* Who waits for the reply to command `id`. */
typedef struct asked {
    int32_t id;
    int64_t browser;
} asked;

typedef struct reply {
    int64_t browser;
    int32_t code;
    char text[512];
} reply;

struct ss_hub {
    ss_hub_config config;
    softsim_client *client; /* hub thread */
    pthread_t thread;
    bool has_thread;
    atomic_bool is_ending, is_broken;
    ss_recorder *recorder;
    bool lacks_mesh; /* hub thread: there is a server, and no whole surface of it */
    int32_t mesh_asks;
    int64_t mesh_asked_ns;
    int32_t server_changes; /* hub thread */
    pthread_mutex_t lock;   /* of all below */
    bool is_changed;
    int64_t start_ns, woken_ns;

    ss_body_view body;
    probe_state probe[SOFTSIM_MAX_PROBES];
    char *scene, *status; /* JSON; NULL: not heard of */
    uint64_t scene_version, status_version;
    int64_t status_ns;
    int64_t session; /* of the server whose status came last */
    bool is_silent;
    uint64_t silence_version;

    ss_mouse mouse;
    int32_t mouse_probe;
    int64_t mouse_browser;                 /* 0: nobody */
    bool is_refused;                       /* another program has the probe that it holds */
    uint8_t tools;                         /* bit n: the scene, once there is one, has tool n */
    int64_t device_ns[SOFTSIM_MAX_PROBES]; /* when another program last moved it; 0: never */
    uint8_t devices;                       /* bit n: one moves probe n */
    uint64_t hand_version;
    int32_t pose_seq;

    command command[COMMANDS];
    uint64_t command_put, command_taken;
    asked asked[ASKED]; /* by the remainder of the id */
    reply reply[REPLIES];
    uint64_t reply_count;

    uint64_t recording_version; /* that browsers were woken for */
};

/* ---- heard: hub thread ---- */

static void mark_changed(ss_hub *hub)
{
    hub->is_changed = true;
}

#define TAKE(name, type)                                                                           \
    static void take_##name(void *context, const type *message)                                    \
    {                                                                                              \
        ss_hub *hub = context;                                                                     \
        pthread_mutex_lock(&hub->lock);                                                            \
        (void)ss_body_take_##name(&hub->body, message);                                            \
        mark_changed(hub);                                                                         \
        pthread_mutex_unlock(&hub->lock);                                                          \
    }
TAKE(topology, softsim_topology_chunk)
TAKE(delta, softsim_mesh_delta)
TAKE(field, softsim_mesh_field)

static void take_pose(void *context, const softsim_pose *pose, int32_t channel)
{
    ss_hub *hub = context;
    pthread_mutex_lock(&hub->lock);
    probe_state *probe = &hub->probe[channel];
    if (pose->sender != softsim_client_sender(hub->client)) {
        hub->device_ns[channel] = softsim_client_now_ns();
    }
    /* Of who is answered; at first of anyone. */
    if (ss_is_finite(pose->position, 3) && ss_is_finite(pose->orientation, 4) &&
        (probe->heard_ns == 0 || pose->sender == probe->force.sender)) {
        probe->pose = *pose;
        probe->has_pose = true;
    }
    pthread_mutex_unlock(&hub->lock);
}

static void take_sample(ss_hub *hub, probe_state *probe, int64_t now_ns)
{
    const float force = (float)ss_norm3(probe->force.force);
    sample *open = &probe->open;
    if (probe->sample_ns == 0 || now_ns - probe->sample_ns >= FRAME_NS) {
        probe->sample_ns = now_ns;
        probe->ring[probe->count++ % SAMPLES] = *open;
        *open = (sample){0};
        mark_changed(hub);
    }
    open->time_s = (float)(1e-9 * (double)(now_ns - hub->start_ns));
    open->force = force;
    open->peak = fmaxf(open->peak, force);
    open->indentation = (float)probe->indentation.value;
}

static void take_force(void *context, const softsim_force *force, int64_t receive_ns)
{
    ss_hub *hub = context;
    pthread_mutex_lock(&hub->lock);
    probe_state *probe = &hub->probe[force->probe];
    const bool is_mine = force->sender == softsim_client_sender(hub->client);
    const bool is_refused = (force->flags & SOFTSIM_FORCE_OTHER_SENDER) != 0;
    /* Not of one that was let go meanwhile. */
    if (is_mine && hub->mouse_browser != 0 && force->probe == hub->mouse_probe &&
        is_refused != hub->is_refused) {
        hub->is_refused = is_refused;
        ++hub->hand_version;
        mark_changed(hub);
    }
    if (!is_refused) {
        probe->force = *force;
        probe->heard_ns = receive_ns;
        ss_indentation_take(&probe->indentation, force,
                            probe->has_pose ? probe->pose.position : force->proxy);
        take_sample(hub, probe, receive_ns);
    }
    pthread_mutex_unlock(&hub->lock);
}

/* The probe is anyone's again. */
static void let_go(ss_hub *hub)
{
    ss_mouse_drop(&hub->mouse);
    hub->mouse_browser = 0;
    hub->is_refused = false;
    ++hub->hand_version;
    mark_changed(hub);
}

/* In place of a text; NULL leaves the old one. */
static void renew(char **text, char *json, uint64_t *version)
{
    if (json != NULL) {
        free(*text);
        *text = json;
        ++*version;
    }
}

static void take_status(void *context, const softsim_server_status *status, int64_t receive_ns)
{
    ss_hub *hub = context;
    char *json = ss_json_of_status(status);
    const int64_t session = ss_session_of(status);
    pthread_mutex_lock(&hub->lock);
    if (hub->status_ns != 0 && session != hub->session) {
        ss_body_begin_session(&hub->body);
    }
    hub->session = session;
    hub->lacks_mesh = hub->status_ns != 0 && !hub->body.is_complete;
    renew(&hub->status, json, &hub->status_version);
    hub->status_ns = receive_ns;
    if (hub->is_silent) {
        hub->is_silent = false;
        ++hub->silence_version;
    }
    mark_changed(hub);
    pthread_mutex_unlock(&hub->lock);
}

static void take_scene(void *context, const softsim_scene_report *scene)
{
    ss_hub *hub = context;
    char *json = ss_json_of_scene(scene, hub->session);
    uint8_t tools = 0;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        tools |= (uint8_t)(scene->form[p] != SOFTSIM_TOOL_NONE ? 1U << p : 0);
    }
    pthread_mutex_lock(&hub->lock);
    hub->tools = tools;
    if (hub->mouse_browser != 0 && (tools >> hub->mouse_probe & 1) == 0) {
        let_go(hub);
    }
    hub->mouse.max_jump_m = ss_parameter_of(scene, "haptic.max_jump_m");
    if (hub->scene == NULL || json == NULL || strcmp(hub->scene, json) != 0) {
        renew(&hub->scene, json, &hub->scene_version);
        mark_changed(hub);
    } else {
        free(json);
    }
    pthread_mutex_unlock(&hub->lock);
}

static void answer(ss_hub *hub, int64_t browser, int32_t code, const char *text)
{
    reply *next = &hub->reply[hub->reply_count % REPLIES];
    next->browser = browser;
    next->code = code;
    snprintf(next->text, sizeof next->text, "%s", text);
    ++hub->reply_count;
    mark_changed(hub);
}

static void take_reply(void *context, int32_t id, int32_t code, const char *text)
{
    ss_hub *hub = context;
    pthread_mutex_lock(&hub->lock);
    asked *waits = &hub->asked[(uint32_t)id % ASKED];
    if (id > 0 && waits->id == id) {
        answer(hub, waits->browser, code, text);
        waits->id = 0;
    }
    pthread_mutex_unlock(&hub->lock);
}

static void take_raw(void *context, const char *channel, const void *data, int32_t size)
{
    ss_hub *hub = context;
    ss_recorder_take(hub->recorder, softsim_client_now_us(), channel, data, size);
}

/* ---- the hub's thread ---- */

static void send_pose(ss_hub *hub, int64_t now_ns)
{
    softsim_pose pose = {.force_seq = -1, .applied_force = {(double)NAN, (double)NAN, (double)NAN}};
    pthread_mutex_lock(&hub->lock);
    const bool was_held = hub->mouse.is_held;
    const bool is_due = ss_mouse_move(&hub->mouse, now_ns, &pose);
    if (was_held && !hub->mouse.is_held) {
        let_go(hub);
    }
    pose.probe = hub->mouse_probe;
    pose.seq = is_due ? ++hub->pose_seq : 0;
    pthread_mutex_unlock(&hub->lock);
    if (is_due) {
        pose.utime_us = now_ns / 1000;
        pose.sender = softsim_client_sender(hub->client);
        softsim_client_send_pose(hub->client, &pose, pose.probe);
    }
}

static void send_commands(ss_hub *hub)
{
    for (;;) {
        pthread_mutex_lock(&hub->lock);
        const bool is_there = hub->command_taken != hub->command_put;
        const command next = hub->command[hub->command_taken % COMMANDS];
        hub->command_taken += is_there;
        pthread_mutex_unlock(&hub->lock);
        if (!is_there) {
            return;
        }
        const int32_t id = softsim_client_send_command(hub->client, next.name, next.argument);
        pthread_mutex_lock(&hub->lock);
        if (id > 0) {
            hub->asked[(uint32_t)id % ASKED] = (asked){id, next.browser};
        } else {
            answer(hub, next.browser, 2,
                   "not sent: give a name and no control characters, or LCM has failed");
        }
        pthread_mutex_unlock(&hub->lock);
    }
}

/* Notes which probes other programs move, by now. */
static void look_for_devices(ss_hub *hub, int64_t now_ns)
{
    uint8_t devices = 0;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        const bool is_moved = hub->device_ns[p] != 0 && now_ns - hub->device_ns[p] < DEVICE_NS;
        devices |= (uint8_t)(is_moved ? 1U << p : 0);
    }
    if (devices != hub->devices) {
        hub->devices = devices;
        ++hub->hand_version;
        mark_changed(hub);
    }
}

/* Notes who has fallen silent, and wakes the browsers' side when there is something new. When to
 * look again. */
static int64_t look_around(ss_hub *hub, int64_t now_ns)
{
    pthread_mutex_lock(&hub->lock);
    if (hub->recording_version != ss_recorder_version(hub->recorder)) {
        hub->recording_version = ss_recorder_version(hub->recorder);
        mark_changed(hub);
    }
    look_for_devices(hub, now_ns);
    const int64_t heard_ns = hub->status_ns != 0 ? hub->status_ns : hub->start_ns;
    if (!hub->is_silent && now_ns - heard_ns > SILENT_NS) {
        hub->is_silent = true;
        ++hub->silence_version;
        mark_changed(hub);
    }
    const bool is_due = now_ns - hub->woken_ns >= (hub->is_changed ? FRAME_NS : HEARTBEAT_NS);
    int64_t next_ns = now_ns + (hub->mouse.is_held ? POSE_NS : IDLE_NS);
    if (is_due) {
        hub->is_changed = false;
        hub->woken_ns = now_ns;
    } else if (hub->is_changed && hub->woken_ns + FRAME_NS < next_ns) {
        next_ns = hub->woken_ns + FRAME_NS;
    }
    pthread_mutex_unlock(&hub->lock);
    if (is_due) {
        hub->config.wake(hub->config.context);
    }
    return next_ns;
}

/* A surface at rest comes every ten seconds: who has none yet asks for it, a few times, since a
 * server may have none to show. */
static void ask_for_mesh(ss_hub *hub, int64_t now_ns)
{
    hub->mesh_asks = hub->lacks_mesh ? hub->mesh_asks : 0;
    if (hub->lacks_mesh && hub->mesh_asks < MESH_ASKS &&
        now_ns - hub->mesh_asked_ns >= MESH_ASK_NS) {
        ++hub->mesh_asks;
        hub->mesh_asked_ns = now_ns;
        (void)softsim_client_send_command(hub->client, "refresh", "");
    }
}

/* A recording of two servers is not one body's. */
static void look_for_servers(ss_hub *hub)
{
    const int32_t changes = softsim_client_server_changes(hub->client);
    if (changes != hub->server_changes || softsim_client_hears_two(hub->client)) {
        hub->server_changes = changes;
        ss_recorder_mark_servers(hub->recorder);
    }
}

static void *run(void *argument)
{
    ss_hub *hub = argument;
    int64_t pose_ns = 0;
    /* As a bridge has: poses that come late are refused, and the force is let go. */
    (void)ss_process_raise_priority();
    while (!atomic_load(&hub->is_ending)) {
        int64_t now_ns = softsim_client_now_ns();
        send_commands(hub);
        ask_for_mesh(hub, now_ns);
        if (now_ns >= pose_ns) {
            send_pose(hub, now_ns);
            pose_ns = now_ns + POSE_NS;
        }
        const int64_t next_ns = look_around(hub, now_ns);
        if (softsim_client_wait(hub->client, next_ns) < 0) {
            atomic_store(&hub->is_broken, true);
            hub->config.wake(hub->config.context);
            break;
        }
        look_for_servers(hub);
    }
    return NULL;
}

/* ---- opening ---- */

void ss_hub_stop(ss_hub *hub)
{
    if (hub != NULL && hub->has_thread) {
        atomic_store(&hub->is_ending, true);
        pthread_join(hub->thread, NULL);
        hub->has_thread = false;
    }
}

void ss_hub_close(ss_hub **hub, softsim_error *error)
{
    ss_hub *h = *hub;
    if (h == NULL) {
        return;
    }
    ss_hub_stop(h);
    softsim_client_close(&h->client);
    ss_recorder_close(&h->recorder, error);
    ss_body_free(&h->body);
    free(h->scene);
    free(h->status);
    pthread_mutex_destroy(&h->lock);
    free(h);
    *hub = NULL;
}

softsim_status ss_hub_open(const ss_hub_config *config, ss_hub **out_hub, softsim_error *error)
{
    *out_hub = NULL;
    ss_hub *hub = calloc(1, sizeof *hub);
    if (hub == NULL) {
        return ss_memory_fault(error);
    }
    hub->config = *config;
    hub->start_ns = softsim_client_now_ns();
    ss_process_init_lock(&hub->lock);
    const softsim_client_config client = {.lcm_url = config->lcm_url,
                                          .prefix = config->prefix,
                                          .context = hub,
                                          .hears_all = true,
                                          .handle_force = take_force,
                                          .handle_status = take_status,
                                          .handle_reply = take_reply,
                                          .handle_scene = take_scene,
                                          .handle_topology = take_topology,
                                          .handle_delta = take_delta,
                                          .handle_field = take_field,
                                          .handle_pose = take_pose,
                                          .handle_raw = take_raw};
    const ss_recorder_config recorder = {.folder = config->record_dir,
                                         .is_temporary = config->is_temporary,
                                         .most_bytes = MOST_RECORDED,
                                         .most_in_all = MOST_RECORDED_IN_ALL,
                                         .most_files = RECORDINGS,
                                         .ring_bytes = RECORDER_ROOM};
    softsim_status status = ss_recorder_open(&recorder, &hub->recorder, error);
    if (status == SOFTSIM_OK) {
        /* A browser begins with 0, and is told of all once. */
        hub->silence_version = hub->hand_version = 1;
        hub->recording_version = ss_recorder_version(hub->recorder);
        status = softsim_client_open(&client, &hub->client, error);
    }
    if (status == SOFTSIM_OK && pthread_create(&hub->thread, NULL, run, hub) != 0) {
        status = SOFTSIM_ERROR_SYSTEM;
        softsim_error_add(error, status, "cannot start a thread; raise `ulimit -u`");
    }
    hub->has_thread = status == SOFTSIM_OK;
    *out_hub = hub;
    if (status != SOFTSIM_OK) {
        ss_hub_close(out_hub, error);
    }
    return status;
}

bool ss_hub_is_broken(const ss_hub *hub)
{
    return atomic_load(&hub->is_broken);
}

/* ---- for browsers ---- */

static float *put_numbers(float *at, const double *value, int count)
{
    for (int i = 0; i < count; ++i) {
        *at++ = (float)value[i];
    }
    return at;
}

/* As hub.h has it. */
static void describe_force(const probe_state *probe, float out_state[STATE_FLOATS])
{
    static const double upright[4] = {1.0, 0.0, 0.0, 0.0};
    const softsim_force *f = &probe->force;
    const double last[] = {f->depth, probe->indentation.value, f->stiffness,
                           1e-6 * (double)f->model_age_us};
    float *at = out_state;
    *at++ = (float)f->flags;
    at = put_numbers(at, probe->has_pose ? probe->pose.position : f->proxy, 3);
    at = put_numbers(at, probe->has_pose ? probe->pose.orientation : upright, 4);
    at = put_numbers(at, f->proxy, 3);
    at = put_numbers(at, f->point, 3);
    at = put_numbers(at, f->normal, 3);
    at = put_numbers(at, f->force, 3);
    at = put_numbers(at, f->torque, 3);
    put_numbers(at, last, 4);
}

static uint8_t *force_frame(const ss_hub *hub, ss_hub_view *view, int32_t p, size_t before,
                            size_t *out_size)
{
    const probe_state *probe = &hub->probe[p];
    const uint64_t oldest = probe->count > SAMPLES ? probe->count - SAMPLES : 0;
    uint64_t next = view->sample[p] > oldest ? view->sample[p] : oldest;
    const uint16_t count = (uint16_t)(probe->count - next);
    float state[STATE_FLOATS];
    *out_size = 4 + sizeof state + (size_t)count * sizeof(sample);
    uint8_t *frame = malloc(before + *out_size);
    if (frame == NULL) {
        return NULL;
    }
    uint8_t *at = frame + before;
    *at++ = 4;
    *at++ = (uint8_t)p;
    memcpy(at, &count, sizeof count);
    at += sizeof count;
    describe_force(probe, state);
    memcpy(at, state, sizeof state);
    at += sizeof state;
    for (; next < probe->count; ++next) {
        memcpy(at, &probe->ring[next % SAMPLES], sizeof(sample));
        at += sizeof(sample);
    }
    view->sample[p] = probe->count;
    return frame;
}

static uint8_t *text_message(const char *text, size_t before, size_t *out_size)
{
    *out_size = strlen(text);
    uint8_t *message = malloc(before + *out_size);
    if (message != NULL) {
        memcpy(message + before, text, *out_size);
    }
    return message;
}

static uint8_t *hand_text(const ss_hub *hub, const ss_hub_view *view, size_t before, size_t *size)
{
    char devices[4 * SOFTSIM_MAX_PROBES] = "", text[224];
    int length = 0;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if ((hub->devices >> p & 1) != 0) {
            length += snprintf(devices + length, sizeof devices - (size_t)length, "%s%d",
                               length > 0 ? ", " : "", p);
        }
    }
    const char *who = hub->mouse_browser == 0               ? "nobody"
                      : hub->mouse_browser == view->browser ? "you"
                                                            : "another browser";
    snprintf(text, sizeof text,
             "{\"type\": \"hand\", \"holder\": \"%s\", \"refused\": %s, \"probe\": %d, "
             "\"devices\": [%s]}",
             who, hub->is_refused ? "true" : "false",
             hub->mouse_browser != 0 ? hub->mouse_probe : -1, devices);
    return text_message(text, before, size);
}

static uint8_t *recording_text(const ss_hub *hub, size_t before, size_t *out_size)
{
    char *json = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&json, &size);
    if (out == NULL) {
        return NULL;
    }
    ss_recorder_tell(hub->recorder, out);
    fclose(out);
    uint8_t *message = json != NULL ? text_message(json, before, out_size) : NULL;
    free(json);
    return message;
}

static uint8_t *next_reply(const ss_hub *hub, ss_hub_view *view, size_t before, size_t *out_size)
{
    if (hub->reply_count - view->reply > REPLIES) {
        view->reply = hub->reply_count - REPLIES;
    }
    while (view->reply < hub->reply_count) {
        const reply *next = &hub->reply[view->reply++ % REPLIES];
        char *json = NULL;
        size_t size = 0;
        FILE *out = next->browser == view->browser ? open_memstream(&json, &size) : NULL;
        if (out == NULL) {
            continue;
        }
        fprintf(out, "{\"type\": \"reply\", \"code\": %d, \"text\": ", next->code);
        ss_plain_json(out, next->text);
        fputs("}", out);
        fclose(out);
        uint8_t *message = json != NULL ? text_message(json, before, out_size) : NULL;
        free(json);
        return message;
    }
    return NULL;
}

static bool is_behind(uint64_t *seen, uint64_t version)
{
    const bool is_behind = *seen != version;
    *seen = version;
    return is_behind;
}

static uint8_t *next_text(const ss_hub *hub, ss_hub_view *view, size_t before, size_t *size)
{
    if (hub->scene != NULL && is_behind(&view->scene, hub->scene_version)) {
        return text_message(hub->scene, before, size);
    }
    if (hub->status != NULL && is_behind(&view->status, hub->status_version)) {
        return text_message(hub->status, before, size);
    }
    if (is_behind(&view->silence, hub->silence_version)) {
        return text_message(hub->is_silent ? "{\"type\": \"silent\", \"is_silent\": true}"
                                           : "{\"type\": \"silent\", \"is_silent\": false}",
                            before, size);
    }
    if (is_behind(&view->hand, hub->hand_version)) {
        return hand_text(hub, view, before, size);
    }
    if (is_behind(&view->recording, hub->recording_version)) {
        return recording_text(hub, before, size);
    }
    return next_reply(hub, view, before, size);
}

uint8_t *ss_hub_next(ss_hub *hub, ss_hub_view *view, size_t before, size_t *out_size,
                     bool *out_is_text)
{
    pthread_mutex_lock(&hub->lock);
    *out_is_text = true;
    uint8_t *message = next_text(hub, view, before, out_size);
    if (message == NULL && !ss_body_has_topology(&hub->body, &view->body)) {
        *out_is_text = false; /* what a late browser's first forces are of */
        message = ss_body_frame(&hub->body, &view->body, before, out_size);
    }
    const int64_t now_ns = softsim_client_now_ns();
    for (int32_t p = 0; message == NULL && p < SOFTSIM_MAX_PROBES; ++p) {
        const probe_state *probe = &hub->probe[p];
        if (view->sample[p] != probe->count && now_ns - probe->heard_ns < FORCE_SILENT_NS) {
            *out_is_text = false;
            message = force_frame(hub, view, p, before, out_size);
        }
    }
    if (message == NULL) {
        *out_is_text = false;
        message = ss_body_frame(&hub->body, &view->body, before, out_size);
    }
    pthread_mutex_unlock(&hub->lock);
    return message;
}

bool ss_hub_is_held_by(ss_hub *hub, const ss_hub_view *view)
{
    pthread_mutex_lock(&hub->lock);
    const bool is_held = hub->mouse_browser == view->browser;
    pthread_mutex_unlock(&hub->lock);
    return is_held;
}

void ss_hub_drop(ss_hub *hub, const ss_hub_view *view)
{
    pthread_mutex_lock(&hub->lock);
    if (hub->mouse_browser == view->browser) {
        let_go(hub);
    }
    pthread_mutex_unlock(&hub->lock);
}

bool ss_hub_aim(ss_hub *hub, const ss_hub_view *view, int32_t probe, const ss_mouse_aim *aim)
{
    pthread_mutex_lock(&hub->lock);
    const bool is_free = hub->mouse_browser == 0;
    const bool is_mine = hub->mouse_browser == view->browser && hub->mouse_probe == probe;
    bool is_taken = probe >= 0 && probe < SOFTSIM_MAX_PROBES && (is_free || is_mine) &&
                    (hub->scene == NULL || (hub->tools >> probe & 1) != 0);
    is_taken = is_taken && ss_mouse_aim_at(&hub->mouse, aim, softsim_client_now_ns());
    if (is_taken && is_free) {
        hub->mouse_browser = view->browser;
        hub->mouse_probe = probe;
        ++hub->hand_version;
        mark_changed(hub);
    }
    pthread_mutex_unlock(&hub->lock);
    return is_taken;
}

void ss_hub_command(ss_hub *hub, const ss_hub_view *view, const char *name, const char *argument)
{
    pthread_mutex_lock(&hub->lock);
    if (strcmp(name, "shutdown") == 0) {
        answer(hub, view->browser, 1, "stop the server where it was started");
    } else if (hub->command_put - hub->command_taken == COMMANDS) {
        answer(hub, view->browser, 1, "too many commands wait to be sent; say it again");
    } else {
        command *next = &hub->command[hub->command_put++ % COMMANDS];
        next->browser = view->browser;
        snprintf(next->name, sizeof next->name, "%s", name);
        snprintf(next->argument, sizeof next->argument, "%s", argument);
    }
    pthread_mutex_unlock(&hub->lock);
}

void ss_hub_record(ss_hub *hub, bool is_wanted)
{
    ss_recorder_want(hub->recorder, is_wanted);
}

const char *ss_hub_recording(ss_hub *hub, const char *name)
{
    return ss_recorder_path(hub->recorder, name);
}
