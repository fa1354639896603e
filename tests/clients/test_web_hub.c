/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-web's hub over a real LCM, with a disk and a server of ours: what a slow disk may hold
 * up, who is told of a refusal, whose a reply is.
 */
#include "common/test.h"

#include <errno.h>
#include <lcm/lcm.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/folder_fixture.h"
#include "hub.h"
#include "net/codec.h"
#include "process/process.h"
#include "softsim/log.h"
#include "softsim_command_t.h"
#include "softsim_reply_t.h"

/* ---- a disk that stands still ---- */

static sem_t stalled, going_on;
static atomic_bool is_slow, is_stalled;

int __real_fsync(int descriptor);
int __wrap_fsync(int descriptor);

/* Until the test says so; half a minute stands against hanging alone. */
int __wrap_fsync(int descriptor)
{
    if (atomic_exchange(&is_slow, false)) {
        struct timespec end;
        clock_gettime(CLOCK_REALTIME, &end);
        end.tv_sec += 30;
        atomic_store(&is_stalled, true);
        sem_post(&stalled);
        while (sem_timedwait(&going_on, &end) != 0 && errno == EINTR) {
        }
        atomic_store(&is_stalled, false);
    }
    return __real_fsync(descriptor);
}

/* ---- the hub, and who hears it ---- */

static ss_hub *hub;
static ss_hub_view view;
static lcm_t *lcm;
static int poses, commands;
static int64_t sender; /* of the poses */
static softsim_command_t_subscription_t *heard_commands;
static softsim_command_t first, last;

static void wake(void *context)
{
    (void)context;
}

static void count_pose(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    softsim_pose pose;
    (void)channel;
    (void)context;
    if (softsim_log_decode_pose(buffer->data, (int32_t)buffer->data_size, &pose)) {
        ++poses;
        sender = pose.sender;
    }
}

static void count_command(const lcm_recv_buf_t *buffer, const char *channel,
                          const softsim_command_t *command, void *context)
{
    last = *command; /* its numbers */
    first = commands++ == 0 ? last : first;
}

static int open_hub(void **state)
{
    softsim_error error = {.status = SOFTSIM_OK};
    make_folder(state);
    sem_init(&stalled, 0, 0);
    sem_init(&going_on, 0, 0);
    lcm = lcm_create(NULL);
    assert_non_null(lcm);
    lcm_subscribe(lcm, "SOFTSIM_PROBE_0", count_pose, NULL);
    view = (ss_hub_view){.browser = 1};
    commands = 0;
    heard_commands = softsim_command_t_subscribe(lcm, "SOFTSIM_COMMAND", count_command, NULL);
    const ss_hub_config config = {.record_dir = folder, .wake = wake};
    assert_int_equal(ss_hub_open(&config, &hub, &error), SOFTSIM_OK);
    return 0;
}

static int close_hub(void **state)
{
    ss_hub_close(&hub, NULL);
    softsim_command_t_unsubscribe(lcm, heard_commands);
    lcm_destroy(lcm);
    return remove_folder(state);
}

/* The next text of a browser with `part`, which has to have `rest` too. */
static void expect_text_of(ss_hub_view *browser, const char *part, const char *rest)
{
    for (;;) {
        size_t size = 0;
        bool is_text = false;
        uint8_t *message = ss_hub_next(hub, browser, 0, &size, &is_text);
        const bool is_it = message != NULL && is_text && memmem(message, size, part, strlen(part));
        const bool is_right = is_it && memmem(message, size, rest, strlen(rest));
        free(message);
        if (is_it) {
            assert_true(is_right);
            return;
        }
        lcm_handle_timeout(lcm, 5);
    }
}

static void expect_text(const char *part)
{
    expect_text_of(&view, part, part);
}

/* ---- a server's words ---- */

/* To the hub, of probe 0; then one to another, after which the first has been heard. */
static void send_force(int32_t flags)
{
    uint8_t data[SS_WIRE_FORCE_SIZE];
    softsim_force force = {.flags = flags, .sender = sender};
    ss_hub_view watcher = {.browser = 3};
    for (int k = 0; k < 2; ++k) {
        ss_wire_encode_force(&force, data);
        lcm_publish(lcm, "SOFTSIM_FORCE_0", data, sizeof data);
        force = (softsim_force){.sender = sender + 1};
    }
    for (bool is_heard = false; !is_heard;) {
        size_t size = 0;
        bool is_text = false;
        uint8_t *message = ss_hub_next(hub, &watcher, 0, &size, &is_text);
        is_heard = message != NULL && !is_text && message[0] == 4;
        free(message);
        lcm_handle_timeout(lcm, 1);
    }
}

static void reply_to(const softsim_command_t *command, char *text)
{
    const softsim_reply_t reply = {.sender = command->sender, .id = command->id, .text = text};
    softsim_reply_t_publish(lcm, "SOFTSIM_REPLY", &reply);
}

/* While the disk is busy for as long as it likes, the probe goes on and browsers are told. */
TEST_WITH(a_slow_disk_holds_up_no_pose, open_hub, close_hub)
{
    const ss_mouse_aim aim = {.position = {0.0, 0.0, 0.1}, .orientation = {1.0, 0.0, 0.0, 0.0}};
    ss_hub_record(hub, true);
    expect_text("\"is_recording\": true");
    atomic_store(&is_slow, true);
    ss_hub_record(hub, false);
    while (sem_wait(&stalled) != 0) {
    }
    poses = 0;
    while (poses < 100 && atomic_load(&is_stalled)) {
        assert_true(ss_hub_aim(hub, &view, 0, &aim));
        lcm_handle_timeout(lcm, 100);
        size_t size = 0;
        bool is_text = false;
        free(ss_hub_next(hub, &view, 0, &size, &is_text));
    }
    assert_true(atomic_load(&is_stalled));
    sem_post(&going_on);
    expect_text("\"is_recording\": false, \"fault\": \"\", \"files\": [\"softsim-");
}

/* One who took the probe from nobody is not told of the refusal of another before. */
TEST_WITH(a_refusal_ends_with_who_was_refused, open_hub, close_hub)
{
    const ss_mouse_aim aim = {.position = {0.0, 0.0, 0.1}, .orientation = {1.0, 0.0, 0.0, 0.0}};
    for (int way = 0; way < 2; ++way) {
        assert_true(ss_hub_aim(hub, &view, 0, &aim));
        expect_text_of(&view, "\"holder\": \"you\"", "\"refused\": false");
        for (poses = 0; poses == 0;) {
            lcm_handle_timeout(lcm, 100);
        }
        if (way == 0) { /* refused, and not heard of for long */
            send_force(SOFTSIM_FORCE_OTHER_SENDER);
            expect_text_of(&view, "\"holder\": \"you\"", "\"refused\": true");
        } else { /* the refusal comes late */
            ss_hub_drop(hub, &view);
            send_force(SOFTSIM_FORCE_OTHER_SENDER);
        }
        expect_text_of(&view, "\"holder\": \"nobody\"", "\"refused\": false");
    }
    assert_true(ss_hub_aim(hub, &view, 0, &aim));
    expect_text_of(&view, "\"holder\": \"you\"", "\"refused\": false");
}

/* However many others ask before it comes. */
TEST_WITH(a_reply_goes_to_who_asked, open_hub, close_hub)
{
    enum { OTHERS = 1100 };
    ss_hub_view other = {.browser = 2};
    ss_hub_command(hub, &view, "status", "");
    for (int sent = 1; sent <= OTHERS; ++sent) {
        while (commands < sent) {
            lcm_handle_timeout(lcm, 100);
        }
        ss_hub_command(hub, &other, "status", "");
    }
    while (commands <= OTHERS) {
        lcm_handle_timeout(lcm, 100);
    }
    reply_to(&first, "first");
    reply_to(&last, "last");
    expect_text_of(&other, "\"type\": \"reply\"", "\"last\"");
    ss_hub_command(hub, &view, "status", "");
    while (commands <= OTHERS + 1) {
        lcm_handle_timeout(lcm, 100);
    }
    reply_to(&last, "its own");
    expect_text_of(&view, "\"type\": \"reply\"", "\"its own\"");
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
