/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* A client of a running softsimd, with the bundled kidney: a pose every millisecond for two
 * seconds, pressed 5 mm in, and what comes back. A device takes the place of the position below. */
#include <math.h>
#include <softsim/client.h>
#include <stdio.h>

static void handle_force(void *context, const softsim_force *force, int64_t receive_ns)
{
    (void)receive_ns; /* minus the moment the pose was sent: the delay */
    *(softsim_force *)context = *force;
}

int main(void)
{
    softsim_force newest = {.pose_seq = -1};
    const softsim_client_config config = {.context = &newest, .handle_force = handle_force};
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_client *client = NULL;
    if (softsim_client_open(&config, &client, &error) != SOFTSIM_OK) {
        fprintf(stderr, "%s\n", error.text);
        return 2;
    }
    softsim_pose pose = {.sender = softsim_client_sender(client),
                         .force_seq = -1,
                         .position = {0.0, 0.006, 0.0273}, /* a radius above the tissue */
                         .orientation = {1.0, 0.0, 0.0, 0.0},
                         .velocity = {NAN, NAN, NAN},
                         .applied_force = {NAN, NAN, NAN}};
    int64_t deadline_ns = softsim_client_now_ns();
    for (int tick = 0; tick < 2000; ++tick) {
        pose.seq = tick;
        pose.utime_us = softsim_client_now_us();
        pose.position[2] = 0.0273 - 0.00001 * fmin(tick, 500);
        softsim_client_send_pose(client, &pose, pose.probe);
        deadline_ns += 1000000;
        while (softsim_client_wait(client, deadline_ns) > 0) { /* handles what comes until then */
        }
        if (tick % 200 == 199) {
            printf("%4d ms: %.3f N, %.2f mm deep\n", tick + 1, newest.force[2], 1e3 * newest.depth);
        }
    }
    softsim_client_close(&client);
    return newest.pose_seq >= 0 ? 0 : 1; /* 1: nobody answered */
}
