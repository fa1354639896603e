/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What tools do to every model in the same way: the springs of a grasp, a tool's rotation over a
 * step, and how a set of contacts shares what the hand is told.
 *
 * Grasp (of one potential with the contact): at the button's press the touched nodes store
 * where they are in the tool's frame, o_i = R'(P_i - X), and a stiffness k_i by their weight; the
 * potential gains fade/2 sum k_i |P_i - X - R o_i|^2. On release the fade falls from 1 to 0 in
 * 20 ms, which can only lose energy. (`chainmail` drops it at once.) Where the tissue's reaction
 * on the tool is more than `max_force` at the start of an outer step the grasp is torn: it is
 * released there, and the button takes hold again only when it was let go. Rejected: the springs'
 * part alone; they are stretched against contact that still presses, by more than is felt.
 * Thread: ss_grasp_init set-up only; the rest RT-safe.
 */
#include "models/model.h"
#include "rt/arena.h"

/* Stiffness of a grasp over that of contact, N/m^3 over N/m^3: it shares the stability bound. */
#define SS_GRASP_STIFFNESS_RATIO 0.2

typedef struct ss_grasp {
    double max_force;      /* N, torn above; 0 or NaN: never */
    bool is_pressed;       /* the button is down, and it is not torn */
    bool is_torn;          /* since the button was pressed */
    double fade;           /* 1 while held, then ramped to 0 */
    double fade_before;    /* at the start of the sub-step */
    double unfaded_energy; /* sum k_i |x_i|^2 / 2, J, at fade 1 */
    int32_t count;
    int32_t *node;
    double *stiffness;   /* N/m */
    double (*offset)[3]; /* in the tool's frame */
} ss_grasp;

/* For at most `capacity` nodes. */
void ss_grasp_init(ss_grasp *grasp, int32_t capacity, double max_force, ss_arena *arena);
/* Before an outer step, with the button down or up and the reaction `force` (N) on the tool: is it
 * to hold in this step? */
bool ss_grasp_follow_button(ss_grasp *grasp, bool is_down, const double force[3]);
/* Takes hold of the `count` nodes (increasing) of weight (m^2) times `stiffness` (N/m^3), as they
 * stand displaced by `u` from `rest`, unstretched. */
void ss_grasp_take(ss_grasp *grasp, int32_t count, const int32_t *node, const double *weight,
                   double stiffness, const double (*rest)[3], const ss_real *u,
                   const ss_tool_pose *pose);
/* Stretches the springs just taken so that they push their nodes with `force` (quads) more. */
void ss_grasp_stretch(ss_grasp *grasp, const ss_real *force, const ss_tool_pose *pose);
/* Adds the springs' forces to `force`, and to the tool's force and torque; sets `unfaded_energy`.
 */
void ss_grasp_add_forces(ss_grasp *grasp, const double (*rest)[3], const ss_real *u,
                         const ss_tool_pose *pose, ss_real *force, double tool_force[3],
                         double tool_torque[3]);
/* A released grasp fades by `h` seconds' worth; accept_fade then returns the energy it lost, of the
 * springs as they were at the last evaluation (J). */
void ss_grasp_fade(ss_grasp *grasp, double h);
double ss_grasp_accept_fade(ss_grasp *grasp);
/* FNV-1a of what is state. */
uint64_t ss_grasp_hash(const ss_grasp *grasp, uint64_t seed);

/* Rotation vector of the short way from `from` to `to`. */
void ss_tool_rotation(const ss_tool_pose *from, const ss_tool_pose *to, double out_rotation[3]);

/* The direction in which the tissue pushes the tool with set->force: the first contact's normal
 * where there is only one. `set` has a contact. */
void ss_contact_set_direction(const ss_contact_set *set, double out[3]);
/* The contacts' forces become the whole reaction along that direction (forces that are not the
 * contacts' own included, friction not), and the tool's stiffness and viscosity are shared by
 * force. The reaction then has the friction in it. */
void ss_contact_set_share(ss_contact_set *set, double stiffness, double viscosity);
