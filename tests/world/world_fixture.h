/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Headless worlds of scenes, with the importer as built. cmocka comes first. */
#include "softsim/softsim.h"

/* Fails the test, with what the scene is refused for, when there is no such world. */
static inline softsim_world *make_world_with(const char *scene, softsim_config config)
{
    softsim_error refused = {0};
    config.import_program = BIN_DIR "/softsim-import";
    softsim_world *world = softsim_create(scene, &config, &refused);
    if (world == NULL) {
        fail_msg("%s", refused.text);
    }
    return world;
}

/* With `count` more values, as --set takes them. */
static inline softsim_world *open_scene(const char *scene, const char *const *set, int32_t count)
{
    softsim_config config = softsim_default_config();
    config.set = set;
    config.set_count = count;
    return make_world_with(scene, config);
}
