/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A scene of the models that there are, which must be good. cmocka comes first. */
#include "world/world.h"

static inline ss_scene *load(const char *path)
{
    ss_scene_model models[SS_MAX_MODELS];
    const int32_t count = ss_world_scene_models(models);
    ss_scene *scene = NULL;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(
        ss_scene_load(path, NULL, 0, models, count, BIN_DIR "/softsim-import", &scene, &error),
        SOFTSIM_OK);
    return scene;
}
