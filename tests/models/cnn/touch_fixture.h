/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Tools that go about on bodies of cnn-energy, and a plate under them: shared by the tests of
 * touch. cmocka comes first. */
#include "common/model_fixture.h"

/* The tool goes to (x, y, z) in the next step; the first time it is put there. */
static inline void go(ss_model_tool *tool, double x, double y, double z)
{
    tool->from = tool->to;
    tool->to = (ss_tool_pose){.position = {x, y, z}, .orientation = {1.0, 0.0, 0.0, 0.0}};
    if (!tool->is_present) {
        tool->from = tool->to;
        tool->is_present = true;
    }
}

/* One step, after which all tools are where they went. */
static inline void step_tools(setup *s, double dt, ss_model_tool *tool)
{
    steps_with(s, 1, dt, tool);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        tool[k].from = tool[k].to;
    }
}

static inline void settle(setup *s, double dt, ss_model_tool *tool, int count)
{
    for (int k = 0; k < count; ++k) {
        step_tools(s, dt, tool);
    }
}

/* ---- a plate ---- */

#define PLATE_EDGE 0.0045 /* m: about the mean edge, and the radius of most spheres */

/* A plate of 0.1 m, 24 x 24 cells, its border held, under `tools` spheres. */
static inline void setup_plate(setup *s, int tools, double radius, double pretension)
{
    setup_init(s, "cnn-energy", make_plate(24, 0.1));
    hold_rim(s, 24);
    give_skin(s);
    give(s, "pretension_j", pretension);
    for (int k = 0; k < tools; ++k) {
        add_sphere(s, k, radius);
    }
    s->plan.contact_stiffness = 5e7;
}

static inline void create_plate(setup *s, int tools, double radius, double pretension)
{
    setup_plate(s, tools, radius, pretension);
    create(s);
}

/* Presses `probes` spheres in by `depth`, all in the same place, and lets the plate settle. */
static inline void press(setup *s, ss_model_tool *tool, int probes, double x, double radius,
                         double depth)
{
    for (int n = 0; n <= 60; ++n) {
        for (int k = 0; k < probes; ++k) {
            go(&tool[k], x, 0.0007, radius + 1e-3 - (depth + 1e-3) * n / 60.0);
        }
        settle(s, 1e-3, tool, 2);
    }
    settle(s, 1e-3, tool, 200);
}

/* A plate with `tools` spheres of `radius`, the first of them pressed in by `depth` at x. */
static inline void create_pressed(setup *s, int tools, double radius, double pretension,
                                  ss_model_tool tool[SOFTSIM_MAX_PROBES], double x, double depth)
{
    memset(tool, 0, SOFTSIM_MAX_PROBES * sizeof *tool);
    create_plate(s, tools, radius, pretension);
    press(s, tool, 1, x, radius, depth);
}
