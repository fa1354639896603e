/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* A world without a network: a tool is pressed 5 mm into the bundled kidney in half a second, held
 * as long, and what it feels is printed. */
#include <inttypes.h>
#include <math.h>
#include <softsim/softsim.h>
#include <stdio.h>

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: world share/softsim/scenes/kidney.yaml\n");
        return 2;
    }
    softsim_error error = {.status = SOFTSIM_OK};
    const softsim_config config = softsim_default_config();
    softsim_world *world = softsim_create(argv[1], &config, &error);
    if (world == NULL) {
        fprintf(stderr, "%s\n", error.text); /* a line a fault */
        return 2;
    }
    const int32_t probe = 0;
    softsim_pose pose = {.sender = 1,
                         .force_seq = -1,
                         .position = {0.0, 0.006, 0.0273}, /* a radius above the tissue */
                         .orientation = {1.0, 0.0, 0.0, 0.0},
                         .velocity = {NAN, NAN, NAN}, /* it is then taken from the positions */
                         .applied_force = {NAN, NAN, NAN}};
    softsim_force force[SOFTSIM_MAX_PROBES];
    for (int tick = 0; tick < 1000; ++tick) {
        pose.seq = tick;
        pose.utime_us = 1000 * tick;
        pose.position[2] = 0.0273 - 0.00001 * fmin(tick, 500);
        const softsim_refusal refusal = softsim_tick(world, &pose, &probe, 1, force);
        if (refusal != SOFTSIM_ACCEPTED) {
            fprintf(stderr, "tick %d: refused, %s\n", tick, softsim_refusal_name(refusal));
        }
        if (tick % 100 == 99) {
            printf("%4d ms: %.3f N, %.2f mm deep\n", tick + 1, force[probe].force[2],
                   1e3 * force[probe].depth);
        }
    }
    printf("hash %016" PRIx64 "\n", softsim_hash(world));
    softsim_destroy(&world);
    return 0;
}
