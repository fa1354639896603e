/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <signal.h>
#include <stdio.h>

#include "loops/loops.h"
#include "options.h"
#include "rt/note.h"
#include "rt/plain.h"
#include "rt/printer.h"
#include "rt/program.h"
#include "rt/progress.h"
#include "world/world.h"

static void print_line(void *sink, const char *text)
{
    fprintf(sink, "%s\n", text);
}

static void print_note(void *sink, const ss_note *note)
{
    char text[2 * SS_LINE_SIZE];
    ss_note_print(note, text, sizeof text);
    fprintf(sink, "%s\n", text);
}

/* Where warnings go, and how many there were. */
typedef struct warnings {
    FILE *out;        /* NULL: they are only counted */
    const char *path; /* of the scene */
    int32_t count;
} warnings;

static void warn(void *sink, const ss_note *note)
{
    warnings *w = sink;
    ++w->count;
    if (w->out) {
        ss_plain_print(w->out, "softsimd: warning: %s: %s: %s\n", w->path, note->where, note->text);
    }
}

static void tell_note(void *sink, const ss_note *note)
{
    ss_plain_print(stderr, "softsimd: %s: %s: %s\n", (const char *)sink, note->where, note->text);
}

/* What to do next, in one line. */
static void tell_next(const ss_world *world, int32_t warning_count)
{
    const char *path = world->scene->path;
    const char *heed = warning_count > 0 ? "heed the warnings (--explain says more), or " : "";
    if (world->used_probes == 0) {
        ss_plain_print(stderr,
                       "softsimd: next: %sadd a tool under contact.tools (--print-config "
                       "has an example); without: softsim-run %s --duration 1\n",
                       heed, path);
    } else {
        ss_plain_print(stderr,
                       "softsimd: next: %ssoftsimd %s, and when it is ready, in another "
                       "terminal, softsim-bridge --device sim\n",
                       heed, path);
    }
}

/* An exit status, as that of softsim-mesh check. */
static int print_check(const ss_world *world, int32_t warning_count)
{
    char verdict[48] = "good";
    if (warning_count > 0) {
        snprintf(verdict, sizeof verdict, "usable, with %d warning%s", warning_count,
                 warning_count == 1 ? "" : "s");
    }
    const ss_scene *scene = world->scene;
    const int tools = __builtin_popcount(world->used_probes);
    ss_world_advise(world, &(const ss_notes){tell_note, (void *)(uintptr_t)scene->path});
    ss_plain_print(stderr, "softsimd: %s: %s (%d nodes, %d triangles, %s, %d tool%s)\n",
                   scene->path, verdict, scene->mesh->node_count, scene->mesh->triangle_count,
                   scene->model_name, tools, tools == 1 ? "" : "s");
    tell_next(world, warning_count);
    return warning_count > 0 ? 1 : 0;
}

/* Before the loops start their threads, so that only the main thread takes them; not before the
 * scene is loaded, so that a long load can be interrupted. */
static void block_signals(void)
{
    sigset_t signals;
    ss_program_stop_signals(&signals);
    pthread_sigmask(SIG_BLOCK, &signals, NULL);
    signal(SIGPIPE, SIG_IGN);
}

int main(int argc, char **argv)
{
    softsim_error error = {0};
    ss_options options;
    ss_program_begin();
    int exit_code = 0;
    if (!ss_args_may_run(argv[0], ss_options_parse(argc, argv, &options, &error), &error,
                         &exit_code)) {
        return ss_program_finish(argv[0], exit_code);
    }
    const bool is_served = !options.check && !options.explain && !options.print_config;
    const bool is_real_time = is_served && !options.lockstep;
    const ss_world_options world_options = {.scene_path = options.scene_path,
                                            .set = options.set.value,
                                            .set_count = options.set.count,
                                            .threads = (int32_t)options.threads,
                                            .is_lockstep = options.lockstep,
                                            .yardstick = is_real_time ? SS_YARDSTICK_MEASURED : 0.0,
                                            .has_budget = !options.lockstep};
    ss_world *world = NULL;
    ss_program_drop_capabilities(true);
    ss_progress_begin("softsimd", "loading %s", options.scene_path);
    ss_program_begin_setup();
    const softsim_status loaded = ss_world_create(&world_options, &world, &error);
    ss_program_end_setup();
    ss_progress_end();
    if (loaded != SOFTSIM_OK) {
        ss_args_print_error(argv[0], &error);
        if (options.check) {
            fprintf(stderr, "softsimd: next: mend what is named above, and --check again; "
                            "server/scene/README.md has the keys\n");
        }
        return 2;
    }
    warnings told = {.out = options.log_level >= SS_LOG_WARNING ? stderr : NULL,
                     .path = world->scene->path};
    ss_world_doubt(world, &(const ss_notes){warn, &told});
    if (options.check) {
        exit_code = print_check(world, told.count);
    }
    if (options.explain && options.json) {
        ss_world_explain_json(world, stdout);
    } else if (options.explain) {
        ss_world_explain(world, &(const ss_notes){print_note, stdout});
    }
    if (options.print_config) {
        ss_scene_model models[SS_MAX_MODELS];
        ss_world_scene_models(models);
        ss_scene_print(world->scene, &models[world->scene->model_index], print_line, stdout);
    }
    if (is_served) {
        block_signals();
        ss_program_drop_capabilities(false);
        const softsim_status status = ss_loops_run(world, &options, &error);
        if (status != SOFTSIM_OK) {
            ss_args_print_error(argv[0], &error);
            exit_code = status == SOFTSIM_ERROR_ARGUMENT ? 2 : 1; /* a bad url or prefix: 2 */
        }
        if (options.hash) {
            printf("%016llx\n", (unsigned long long)ss_world_hash(world));
        }
    }
    ss_lockstep_stop(world);
    ss_world_destroy(&world);
    return ss_program_finish(argv[0], exit_code);
}
