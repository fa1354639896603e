/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "mouse.h"

#include <math.h>
#include <string.h>

#include "rt/vec.h"

static const int64_t SILENCE_NS = 70000000; /* the server lets go of a pose after 50 ticks */
static const int64_t PATIENCE_NS = 1500000000;
static const double RATE = 40.0;   /* rad/s */
static const double FASTEST = 1.0; /* m/s */
static const double JUMP_SHARE = 0.25;
static const double REACH = 0.03;     /* m: further away is approached by silence */
static const double FARTHEST = 100.0; /* m, that a server takes */

static bool is_good(const ss_mouse_aim *aim)
{
    double square = 0.0;
    for (int k = 0; k < 4; ++k) {
        square += aim->orientation[k] * aim->orientation[k];
    }
    return ss_is_finite(aim->position, 3) && ss_is_finite(aim->orientation, 4) &&
           fabs(sqrt(square) - 1.0) <= 5e-4 && ss_norm3(aim->position) < FARTHEST;
}

/* There at once, at rest; heard of after a silence. */
static void place(ss_mouse *mouse, int64_t now_ns)
{
    memcpy(mouse->position, mouse->aim.position, sizeof mouse->position);
    memcpy(mouse->orientation, mouse->aim.orientation, sizeof mouse->orientation);
    memset(mouse->velocity, 0, sizeof mouse->velocity);
    mouse->start_ns = mouse->sent_ns == 0 ? now_ns : mouse->sent_ns + SILENCE_NS;
}

bool ss_mouse_aim_at(ss_mouse *mouse, const ss_mouse_aim *aim, int64_t now_ns)
{
    if (!is_good(aim)) {
        return false;
    }
    double way[3];
    ss_sub3(way, aim->position, mouse->position);
    const bool is_far = ss_norm3(way) > REACH;
    mouse->aim = *aim;
    if (!mouse->is_held && (mouse->sent_ns == 0 || is_far)) {
        place(mouse, now_ns);
    }
    mouse->is_held = true;
    mouse->aimed_ns = now_ns;
    return true;
}

void ss_mouse_drop(ss_mouse *mouse)
{
    mouse->is_held = false;
}

/* Exact for a still aim: x - a = (p + (v + w p) t) exp(-w t). */
static void follow(ss_mouse *mouse, double passed_s)
{
    const double fade = exp(-RATE * passed_s);
    double step[3];
    for (int d = 0; d < 3; ++d) {
        const double off = mouse->position[d] - mouse->aim.position[d];
        const double slope = mouse->velocity[d] + RATE * off;
        const double next = mouse->aim.position[d] + (off + slope * passed_s) * fade;
        mouse->velocity[d] = (slope - RATE * (off + slope * passed_s)) * fade;
        step[d] = next - mouse->position[d];
    }
    const double allowed = mouse->max_jump_m > 0.0 ? JUMP_SHARE * mouse->max_jump_m : FARTHEST;
    const double longest = fmin(FASTEST * passed_s, allowed), length = ss_norm3(step);
    const double share = length > longest ? longest / length : 1.0;
    for (int d = 0; d < 3; ++d) {
        mouse->position[d] += share * step[d];
        mouse->velocity[d] *= share;
    }
    double dot = 0.0, square = 0.0;
    for (int k = 0; k < 4; ++k) {
        dot += mouse->orientation[k] * mouse->aim.orientation[k];
    }
    for (int k = 0; k < 4; ++k) {
        const double near = dot < 0.0 ? -mouse->aim.orientation[k] : mouse->aim.orientation[k];
        mouse->orientation[k] += (1.0 - fade) * (near - mouse->orientation[k]);
        square += mouse->orientation[k] * mouse->orientation[k];
    }
    for (int k = 0; k < 4; ++k) {
        mouse->orientation[k] /= sqrt(square);
    }
}

bool ss_mouse_move(ss_mouse *mouse, int64_t now_ns, softsim_pose *out_pose)
{
    if (mouse->is_held && now_ns - mouse->aimed_ns > PATIENCE_NS) {
        ss_mouse_drop(mouse);
    }
    if (!mouse->is_held || now_ns < mouse->start_ns) {
        return false;
    }
    const int64_t last_ns = mouse->sent_ns > mouse->start_ns ? mouse->sent_ns : mouse->start_ns;
    const double passed_s = 1e-9 * (double)(now_ns - last_ns);
    follow(mouse, passed_s < 0.02 ? passed_s : 0.02);
    mouse->sent_ns = now_ns;
    memcpy(out_pose->position, mouse->position, sizeof out_pose->position);
    memcpy(out_pose->orientation, mouse->orientation, sizeof out_pose->orientation);
    memcpy(out_pose->velocity, mouse->velocity, sizeof out_pose->velocity);
    out_pose->buttons = mouse->aim.is_grasping ? SOFTSIM_BUTTON_GRASP : 0;
    return true;
}
