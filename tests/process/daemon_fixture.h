/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A daemon on the kidney and a client that watches what it says: shared by the process
 * tests that talk to one over LCM. cmocka comes first. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include <lcm/lcm.h>

#include "common/folder_fixture.h"
#include "common/kidney.h"
#include "process.h"
#include "softsim/types.h"
#include "softsim_command_t.h"
#include "softsim_contact_force_t.h"
#include "softsim_reply_t.h"
#include "softsim_server_status_t.h"

#define SCENES SOURCE_DIR "/server/scenes/"
#define POKE   SCENES "kidney-poke.lcmlog"

static process daemon_process, client, other;

static inline int tear_down(void **state)
{
    process_kill(&client);
    process_kill(&other);
    process_kill(&daemon_process);
    return remove_folder(state);
}

/* A tube of 360 nodes with the kidney's model and tools: for all that is not felt. */
static inline const char *tube(void)
{
    return write_text("tube.yaml",
                      "softsim: 1\n"
                      "object:\n  mesh: " SCENES "cylinder.obj\n  units: cm\n"
                      "  fixed: [{box_m: [[-1, -1, -1], [1, 1, -0.019]]}]\n"
                      "model: {name: cnn-energy, modulus_j: 5, rho: 1, area_density_kg_m2: 11.5,\n"
                      "  damping_n_s_per_m3: 1725, rest_stiffness_n_per_m3: 5.0e+4}\n"
                      "contact:\n  tools:\n"
                      "    - {probe: 0, shape: {sphere: {radius_mm: 5}}}\n"
                      "    - {probe: 1, shape: {sphere: {radius_mm: 6}}}\n");
}

static inline void start_daemon(const char *scene, const char *const *extra)
{
    const char *argv[24] = {"softsimd", scene};
    int count = 2;
    while (extra && *extra) {
        argv[count++] = *extra++;
    }
    process_start(&daemon_process, argv, NULL);
    if (!process_wait_for(&daemon_process, "softsimd: ready")) {
        fail_msg("no ready line; stderr: %s", daemon_process.err);
    }
}

static inline void start_kidney(void)
{
    const char *const small[] = {"--set", kidney_mesh(), NULL};
    start_daemon(KIDNEY, small);
}

static inline int stop_daemon(void)
{
    process_signal(&daemon_process, SIGTERM);
    const int status = process_finish(&daemon_process);
    if (status != 0) {
        print_error("softsimd: %s", daemon_process.err);
    }
    return status;
}

static inline double magnitude(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* ---- a test client ---- */

typedef struct watch {
    lcm_t *lcm;
    softsim_contact_force_t_subscription_t *force_subscription;
    softsim_server_status_t_subscription_t *status_subscription;
    softsim_reply_t_subscription_t *reply_subscription;
    softsim_contact_force_t force;
    int forces;
    softsim_server_status_t status;
    int statuses;
    int reply_code, replies;
    int32_t old_seq;     /* seq of the last force before the last new pose was answered */
    int32_t fresh_seq;   /* seq of the first force that answered it */
    int32_t fresh_flags; /* of the forces since, but for those that say stale */
    double fresh_force;  /* N, of the last that was not stale */
    int32_t felt_seq;    /* seq of the last force that was not zero */
    int32_t zero_seq;    /* seq of the first zero force after them */
    char reason[256], reply[256];
} watch;

static inline void on_force(const lcm_recv_buf_t *buffer, const char *channel,
                            const softsim_contact_force_t *message, void *user)
{
    watch *w = user;
    (void)buffer, (void)channel;
    if (message->pose_seq != w->force.pose_seq) {
        w->old_seq = w->force.seq;
        w->fresh_seq = message->seq;
        w->fresh_flags = 0;
        w->zero_seq = 0;
    }
    if ((message->flags & SOFTSIM_FORCE_STALE) == 0) {
        w->fresh_flags |= message->flags;
        w->fresh_force = magnitude(message->force);
    }
    if (magnitude(message->force) > 0.0) {
        w->felt_seq = message->seq;
        w->zero_seq = 0;
    } else if (w->zero_seq == 0) {
        w->zero_seq = message->seq;
    }
    w->force = *message;
    ++w->forces;
}

static inline void on_status(const lcm_recv_buf_t *buffer, const char *channel,
                             const softsim_server_status_t *message, void *user)
{
    watch *w = user;
    (void)buffer, (void)channel;
    w->status = *message;
    snprintf(w->reason, sizeof w->reason, "%s", message->reason);
    ++w->statuses;
}

static inline void on_reply(const lcm_recv_buf_t *buffer, const char *channel,
                            const softsim_reply_t *message, void *user)
{
    watch *w = user;
    (void)buffer, (void)channel;
    w->reply_code = message->code;
    snprintf(w->reply, sizeof w->reply, "%s", message->text);
    ++w->replies;
}

static inline void watch_open(watch *w)
{
    memset(w, 0, sizeof *w);
    w->lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(w->lcm);
    w->force_subscription =
        softsim_contact_force_t_subscribe(w->lcm, "SOFTSIM_FORCE_0", on_force, w);
    w->status_subscription =
        softsim_server_status_t_subscribe(w->lcm, "SOFTSIM_STATUS", on_status, w);
    w->reply_subscription = softsim_reply_t_subscribe(w->lcm, "SOFTSIM_REPLY", on_reply, w);
}

static inline void watch_close(watch *w)
{
    softsim_contact_force_t_unsubscribe(w->lcm, w->force_subscription);
    softsim_server_status_t_unsubscribe(w->lcm, w->status_subscription);
    softsim_reply_t_unsubscribe(w->lcm, w->reply_subscription);
    lcm_destroy(w->lcm);
}

/* Handles messages until `done` says so; fails when the daemon ends instead. */
static inline void watch_until(watch *w, bool (*done)(const watch *w), const char *what)
{
    const double start_s = process_now_s();
    while (!done(w)) {
        lcm_handle_timeout(w->lcm, 200);
        if (process_has_ended(&daemon_process) || process_now_s() - start_s > HANG_S) {
            fail_msg("waited %.0f s for %s; daemon: %s", process_now_s() - start_s, what,
                     daemon_process.err);
        }
    }
}
