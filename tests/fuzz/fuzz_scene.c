/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * libFuzzer over scenes: the text, and after a byte 0xff the overrides, each ended by another. The
 * folder holds a mesh (cube.msh), a list of nodes (nodes.txt), values (values.csv), directions
 * (grain.csv) and the nodes of a grid (points.csv). A scene is
 * either refused with a fault, or printed; what was printed must load, and print the same again.
 * Build: clang -fsanitize=fuzzer,address,undefined, with ss_scene.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../scene/jelly.h"
#include "scene/scene.h"

const char *__lsan_default_suppressions(void);
int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MAX_OVERRIDES = 8, MAX_PRINT = 1 << 20 };

static const ss_scene_model model = {
    .name = "jelly", .row = jelly_row, .row_count = sizeof jelly_row / sizeof *jelly_row};

static const char cube[] = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
                           "$PhysicalNames\n1\n2 1 \"top\"\n$EndPhysicalNames\n"
                           "$Nodes\n4\n1 0 0 0\n2 20 0 0\n3 0 20 0\n4 0 0 20\n$EndNodes\n"
                           "$Elements\n4\n1 2 2 1 1 1 3 2\n2 2 2 1 1 1 2 4\n3 2 2 2 1 2 3 4\n"
                           "4 2 2 2 1 1 4 3\n$EndElements\n";

static void write_file(const char *name, const char *text)
{
    FILE *stream = fopen(name, "w");
    if (stream == NULL || fputs(text, stream) < 0 || fclose(stream) != 0) {
        abort();
    }
}

/* libfyaml 0.7.12 loses 4 KB when a long scalar turns out wrong; the program ends soon after. */
const char *__lsan_default_suppressions(void)
{
    return "leak:libfyaml";
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    static char folder[] = "/tmp/softsim_fuzz_scene_XXXXXX";
    char name[64];
    if (mkdtemp(folder) == NULL) {
        abort();
    }
    static const struct {
        const char *name, *text;
    } file[] = {{"cube.msh", cube},
                {"nodes.txt", "1\n2\n"},
                {"values.csv", "node,value\n0,1\n1,2\n2,3\n3,4\n"},
                {"points.csv", "x,y,z\n0,0,0\n9,0,0\n0,9,0\n9,9,1\n"},
                {"grain.csv", "element,x,y,z\n0,1,0,0\n1,0,1,0\n2,0,0,1\n3,1,1,1\n"}};
    for (size_t i = 0; i < sizeof file / sizeof *file; i++) {
        snprintf(name, sizeof name, "%s/%s", folder, file[i].name);
        write_file(name, file[i].text);
    }
    setenv("SOFTSIM_FUZZ_FOLDER", folder, 1);
    return 0;
}

static void collect(void *sink, const char *text)
{
    char *all = sink;
    const size_t used = strlen(all);
    if (strchr(text, '\n') != NULL) {
        abort();
    }
    snprintf(all + used, MAX_PRINT - used, "%s\n", text);
}

static ss_scene *load(const char *text, size_t size, const char *const *overrides, int count)
{
    static softsim_error error;
    char path[96];
    ss_scene *scene = NULL;
    snprintf(path, sizeof path, "%s/s.yaml", getenv("SOFTSIM_FUZZ_FOLDER"));
    error = (softsim_error){0};
    const softsim_status status = ss_scene_load_text(path, text, size, overrides, count, &model, 1,
                                                     "/nonexistent", &scene, &error);
    if ((status == SOFTSIM_OK) != (scene != NULL) ||
        (status == SOFTSIM_OK) != (error.fault_count == 0) ||
        (status != SOFTSIM_OK && error.text[0] == '\0')) {
        abort();
    }
    return scene;
}

/* What was printed loads, and prints the same. */
static void check_print(const ss_scene *scene)
{
    static char text[MAX_PRINT];
    static char again[MAX_PRINT];
    text[0] = '\0';
    ss_scene_print(scene, &model, collect, text);
    if (strlen(text) + 1 >= MAX_PRINT) {
        return;
    }
    ss_scene *copy = load(text, strlen(text), NULL, 0);
    if (copy == NULL) {
        abort();
    }
    again[0] = '\0';
    ss_scene_print(copy, &model, collect, again);
    if (strcmp(text, again) != 0) {
        abort();
    }
    ss_scene_destroy(&copy);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *bytes = malloc(size + 1);
    if (bytes == NULL) {
        return 0;
    }
    memcpy(bytes, data, size);
    bytes[size] = '\0';
    const char *override[MAX_OVERRIDES];
    int count = 0;
    char *mark = memchr(bytes, 0xff, size);
    const size_t text_size = mark != NULL ? (size_t)(mark - bytes) : size;
    while (mark != NULL && count < MAX_OVERRIDES) {
        override[count++] = mark + 1;
        *mark = '\0';
        mark = strchr(mark + 1, 0xff);
    }
    if (mark != NULL) {
        *mark = '\0';
    }
    ss_scene *scene = load(bytes, text_size, override, count);
    if (scene != NULL) {
        check_print(scene);
    }
    ss_scene_destroy(&scene);
    if (count > 0) {
        ss_scene_live_key key;
        int32_t row;
        double value;
        if (ss_scene_parse_live(override[0], &model, &key, &row, &value, NULL) == SOFTSIM_OK &&
            !isfinite(value)) {
            abort();
        }
    }
    free(bytes);
    return 0;
}
