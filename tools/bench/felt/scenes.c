/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/scenes.h"

#include <ctype.h>
#include <glob.h>
#include <stdio.h>
#include <string.h>

#include "bench/core/child.h"

void ss_felt_name(const char *path, char out[SS_FELT_NAME_SIZE])
{
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    snprintf(out, SS_FELT_NAME_SIZE, "%.*s", (int)strcspn(name, "."), name);
    for (char *c = out; *c != '\0'; ++c) {
        *c = isalnum((unsigned char)*c) || *c == '-' ? *c : '_';
    }
}

static void add_scene(ss_felt_scenes *scenes, const char *path)
{
    if (scenes->count < SS_FELT_MAX_SCENES) {
        snprintf(scenes->path[scenes->count++], SS_FELT_PATH_SIZE, "%s", path);
    }
}

/* Every scene of a folder; true when there was one. */
static bool add_folder(void *context, const char *folder)
{
    ss_felt_scenes *scenes = context;
    char pattern[SS_FELT_PATH_SIZE];
    glob_t found;
    snprintf(pattern, sizeof pattern, "%s/*.yaml", folder);
    const bool is_good = glob(pattern, 0, NULL, &found) == 0;
    for (size_t i = 0; is_good && i < found.gl_pathc; ++i) {
        add_scene(scenes, found.gl_pathv[i]);
    }
    if (is_good) {
        globfree(&found);
    }
    return scenes->count > 0;
}

/* The bundled ones: of the source tree here or above the program, or as installed beside it. */
static const char *const bundled[] = {"server/scenes", "share/softsim/scenes", NULL};

void ss_felt_list_scenes(const ss_arg_list *asked, ss_felt_scenes *out, softsim_error *error)
{
    *out = (ss_felt_scenes){.count = 0};
    for (int32_t i = 0; i < asked->count; ++i) {
        add_scene(out, asked->value[i]);
    }
    for (int32_t i = 1; i < out->count; ++i) {
        char name[2][SS_FELT_NAME_SIZE];
        ss_felt_name(out->path[i], name[0]);
        for (int32_t k = 0; k < i; ++k) {
            ss_felt_name(out->path[k], name[1]);
            if (strcmp(name[0], name[1]) == 0) {
                softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                                  "--scene: two scenes are called %s, and so would be their "
                                  "pictures; report one of them, or rename it",
                                  name[0]);
            }
        }
    }
    if (out->count == 0) {
        out->is_bundled = true;
        ss_child_look_above(bundled, add_folder, out);
    }
    if (out->count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "no bundled scenes beside this program; give one with --scene");
    }
}
