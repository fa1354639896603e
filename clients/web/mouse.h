/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The probe that a mouse holds. A mouse jumps, 60 times a second at best; a server refuses poses
 * that are further than haptic.max_jump_m from the last, and a hand is felt by how it moves. So the
 * probe follows the place that the mouse aims at as a critically damped mass does,
 *
 *   x'' = w^2 (a - x) - 2 w x',  w = 40 rad/s, |x'| <= 1 m/s,
 *
 * and from one pose to the next no further than a quarter of max_jump_m, since three in a row may
 * be lost,
 * integrated exactly over each period (the closed form of equal roots), and its orientation goes
 * along the shortest arc at the same rate. A place that is out of reach is approached by silence:
 * after 70 ms without a pose the server takes the next one wherever it is.
 * Rejected: a low pass of first order (its velocity jumps with the aim, which is felt as a tap),
 * sending the aim as it comes. Thread: one at a time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

typedef struct ss_mouse_aim {
    double position[3];    /* m, of the tool's origin */
    double orientation[4]; /* w x y z, unit */
    bool is_grasping;
} ss_mouse_aim;

typedef struct ss_mouse {
    double max_jump_m; /* parameter: the server's; 0: not known */
    bool is_held;
    ss_mouse_aim aim;
    double position[3], velocity[3], orientation[4];
    int64_t aimed_ns; /* when it was last aimed */
    int64_t sent_ns;  /* when a pose last went out; 0: never */
    int64_t start_ns; /* no pose before: the server is to be taken by surprise */
} ss_mouse;

/* Takes the probe, or aims it anew. False when a value is not finite, the orientation no unit or
 * the place further than 100 m away, which no server takes. */
bool ss_mouse_aim_at(ss_mouse *mouse, const ss_mouse_aim *aim, int64_t now_ns);
void ss_mouse_drop(ss_mouse *mouse);
/* Moves on to `now_ns` and fills in the pose's position, orientation, velocity and buttons. False
 * when none is to be sent: it is not held, not aimed for 1.5 s (then it is dropped), or
 * silent on purpose. */
bool ss_mouse_move(ss_mouse *mouse, int64_t now_ns, softsim_pose *out_pose);
