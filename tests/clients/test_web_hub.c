/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-web's hub over a real LCM, with a disk of ours: what a slow disk may hold up, and what
 * not.
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
#include "process/process.h"
#include "softsim/log.h"

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

/* ---- the hub, and who hears its poses ---- */

static ss_hub *hub;
static ss_hub_view view = {.browser = 1};
static lcm_t *lcm;
static int poses;

static void wake(void *context)
{
    (void)context;
}

static void count_pose(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    softsim_pose pose;
    (void)channel;
    (void)context;
    poses += softsim_log_decode_pose(buffer->data, (int32_t)buffer->data_size, &pose);
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
    const ss_hub_config config = {.record_dir = folder, .wake = wake};
    assert_int_equal(ss_hub_open(&config, &hub, &error), SOFTSIM_OK);
    return 0;
}

static int close_hub(void **state)
{
    ss_hub_close(&hub);
    lcm_destroy(lcm);
    return remove_folder(state);
}

/* The next text with `part`. */
static void expect_text(const char *part)
{
    for (;;) {
        size_t size = 0;
        bool is_text = false;
        uint8_t *message = ss_hub_next(hub, &view, 0, &size, &is_text);
        const bool is_it = message != NULL && is_text && memmem(message, size, part, strlen(part));
        free(message);
        if (is_it) {
            return;
        }
        lcm_handle_timeout(lcm, 5);
    }
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

int main(void)
{
    return process_run_tests(NULL, NULL);
}
