/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Inputs for every program that needs no server, and which programs there are: shared by the tests
 * of their command lines and of their files. cmocka comes first. */
#include <stdbool.h>

#include "common/tool_fixture.h"

static const char poses[] = "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n"
                            "0,0,0,0,0.05,1,0,0,0,0\n0.02,0,0,0,0.04,1,0,0,0,0\n";
static const char curve[] = "depth_m,force_n\n0.001,1\n0.002,2\n";
static const char compared[] =
    "case,material,model,mesh,nodes,elements,level,error_l2,error_max,error_force,us_per_step_p50,"
    "us_per_step_p99,dt_s,realtime_factor,time_to_1pct_ms,calibrated,verdict\n";
static const char scene[] = "softsim: 1\n"
                            "object:\n"
                            "  mesh: block.msh\n"
                            "  units: m\n"
                            "  fixed: [{group: bottom}]\n"
                            "model: {name: fem, youngs_modulus_pa: 10000, poisson_ratio: 0.3}\n"
                            "contact:\n"
                            "  tools: [{probe: 0, shape: {sphere: {radius_mm: 15}}}]\n";

static inline bool has_program(const char *name)
{
    char path[512];
    (void)snprintf(path, sizeof path, BIN_DIR "/%s", name);
    return access(path, X_OK) == 0;
}

/* Every file that is read; the same bytes afterwards. */
static const struct {
    const char *name, *text;
} inputs[] = {
    {"poses.csv", poses}, {"scene.yaml", scene}, {"curve.csv", curve}, {"accuracy.csv", compared}};
enum { INPUT_COUNT = sizeof inputs / sizeof *inputs };

static inline void write_inputs(void)
{
    char out[4096];
    for (int i = 0; i < INPUT_COUNT; ++i) {
        write_text(inputs[i].name, inputs[i].text);
    }
    assert_int_equal(run(TOOL "generate block --points 100 --tetrahedra --units m --out block.msh",
                         out, sizeof out),
                     0);
}
