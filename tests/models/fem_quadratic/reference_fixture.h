/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The meshes of the reference problems. cmocka comes first. */
#include "common/setup_fixture.h"

static inline ss_mesh *load_reference(const char *name)
{
    char path[512];
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    (void)snprintf(path, sizeof path, SOURCE_DIR "/tests/reference/%s", name);
    if (ss_mesh_load(path, 1.0, NULL, &mesh, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    assert_true(ss_mesh_renumber(mesh));
    return mesh;
}
