/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "common/test.h"

#include <stdio.h>
#include <string.h>

#include "models/model.h"
#include "scene/scene.h"

/* Loads a bundled scene with up to two overrides; NULL with the faults in `error`. */
static ss_scene *load(const char *name, const char *first, const char *second, softsim_error *error)
{
    char path[1024];
    int32_t count = 0;
    const ss_model_class *const *table = ss_model_table(&count);
    ss_scene_model model[16];
    const char *const overrides[] = {first, second};
    ss_scene *scene = NULL;
    for (int32_t k = 0; k < count; ++k) {
        model[k] = (ss_scene_model){.name = table[k]->name,
                                    .row = table[k]->row,
                                    .row_count = table[k]->row_count,
                                    .needs_volume = table[k]->needs_volume};
    }
    *error = (softsim_error){.status = SOFTSIM_OK};
    snprintf(path, sizeof path, "%s/server/scenes/%s", SOURCE_DIR, name);
    (void)ss_scene_load(path, overrides,
                        first == NULL    ? 0
                        : second == NULL ? 1
                                         : 2,
                        model, count, NULL, &scene, error);
    return scene;
}

TEST(outer_surface_makes_a_layer)
{
    softsim_error error;
    ss_scene *scene = load("hm1.yaml", NULL, NULL, &error);
    if (scene == NULL) {
        fail_msg("%s", error.text);
    }
    assert_true(scene->mesh->is_closed);
    assert_int_equal(scene->mesh->tetrahedron_count, 1992);
    assert_int_equal(scene->mesh->node_count, 688 + 1526);
    ss_scene_destroy(&scene);
    scene = load("ed0.yaml", "model.name=hybrid",
                 "model.layer={spacing_m: 0.03, thickness_m: -0.18}", &error);
    if (scene == NULL) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(scene->mesh->node_count, 900);
    assert_true(scene->mesh->tetrahedron_count < 3576);
    ss_scene_destroy(&scene);
}

static void expect(const char *name, const char *first, const char *second, const char *word)
{
    softsim_error error;
    ss_scene *scene = load(name, first, second, &error);
    assert_null(scene);
    if (strstr(error.text, word) == NULL) {
        fail_msg("no '%s' in: %s", word, error.text);
    }
}

TEST(wrong_layers_are_named)
{
    expect("hm1.yaml", "model.name=fem", NULL, "object.outer");
    expect("hm1.yaml", "model.layer.thickness_m=0.1", NULL, "remove one of the two");
    expect("hm1.yaml", "object.outer=hm1.msh", NULL, "rim");
    expect("hm1.yaml", "object.outer=nowhere.msh", NULL, "cannot open");
    expect("hm1.yaml", "model.layer.spacing_m=-1", NULL, "spacing_m");
    expect("hm1.yaml", "model.layer.spacing=1", NULL, "spacing_m");
}

static void print(void *sink, const char *text)
{
    strncat(sink, text, 20000);
    strncat(sink, "\n", 2);
}

/* Printed values make the same scene again: the layer's keys are a mapping there too. */
TEST(layer_is_printed_as_a_mapping)
{
    softsim_error error;
    static char text[60000];
    ss_scene *scene = load("hm1.yaml", NULL, NULL, &error);
    assert_non_null(scene);
    ss_scene_print(scene, NULL, print, text);
    assert_non_null(strstr(text, "  layer:"));
    assert_non_null(strstr(text, "    spacing_m: 0.027"));
    assert_null(strstr(text, "layer.spacing_m"));
    ss_scene_destroy(&scene);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
