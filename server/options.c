/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "options.h"

#include <stddef.h>
#include <stdio.h>

#include "models/model.h"

/* What --help says of the program: its models are those that were built in. */
static void describe(char *out, size_t size)
{
    int32_t count = 0;
    const ss_model_class *const *model = ss_model_table(&count);
    size_t used = (size_t)snprintf(out, size,
                                   "Simulates the scene's soft object; takes probe poses and "
                                   "publishes contact forces over LCM.\nmodel.name in a scene is "
                                   "one of");
    for (int32_t i = 0; i < count && used < size; ++i) {
        used +=
            (size_t)snprintf(out + used, size - used, "%s %s", i > 0 ? "," : "", model[i]->name);
    }
}

ss_args_result ss_options_parse(int argc, char **argv, ss_options *out_options,
                                softsim_error *error)
{
    ss_options o = {.prefix = "SOFTSIM", .threads = 1, .log_level = SS_LOG_INFO};
    int32_t realtime = SS_REALTIME_AUTO;
    int32_t log_level = SS_LOG_INFO;
    const ss_arg rows[] = {
        SS_TEXT("--lcm-url", &o.lcm_url, "URL",
                "LCM provider (default: LCM_DEFAULT_URL, else local multicast, ttl 0)"),
        SS_TEXT("--prefix", &o.prefix, "NAME", "channel prefix (default SOFTSIM)"),
        SS_LIST("--set", &o.set, "PATH=VALUE", "overrides one scene value"),
        SS_FLAG("--check", &o.check,
                "loads, plans and exits: 0 good, 1 usable with warnings, 2 unusable; opens no LCM"),
        SS_FLAG("--explain", &o.explain,
                "prints what this scene uses and what is left out, and exits"),
        SS_FLAG("--json", &o.json,
                "with --explain: as one object of JSON, with bytes, threads and warnings"),
        SS_FLAG("--print-config", &o.print_config, "prints the effective scene values and exits"),
        {"--duration", SS_ARG_NUMBER, &o.duration_s, 1e-6, 1e9, "S",
         "ends S seconds after ready (simulated seconds in lockstep)"},
        SS_FLAG(
            "--no-commands", &o.no_commands,
            "refuses every command but refresh and status (default with an LCM URL of your own)"),
        SS_FLAG("--allow-commands", &o.allow_commands,
                "takes every command (default without an LCM URL of your own)"),
        SS_FLAG(
            "--takeover", &o.takeover,
            "tells the server that answers on the prefix to end, and starts, also beside one that "
            "takes no commands; without it this one refuses to start"),
        SS_CHOICE("--realtime", &realtime, "auto|fifo|off",
                  "SCHED_FIFO for the loops: where allowed, always, never (default auto)"),
        {"--threads", SS_ARG_INTEGER, &o.threads, 1, 64, "N",
         "threads for set-up and workers (default 1); results do not depend on it"},
        SS_FLAG("--lockstep", &o.lockstep,
                "one haptic tick per pose received, nothing else moves time"),
        SS_FLAG("--hash", &o.hash, "prints the final state hash as the last line of stdout"),
        SS_CHOICE("--log-level", &log_level, "error|warning|info",
                  "what stderr tells (default info)"),
    };
    int32_t positional_count = 0;
    char about[1024];
    describe(about, sizeof about);
    const ss_args_result result = ss_args_parse(argc, argv, "[options] SCENE.yaml", about, rows,
                                                (int32_t)(sizeof rows / sizeof *rows),
                                                &o.scene_path, 1, 1, &positional_count, error);
    if (result == SS_ARGS_RUN && o.json && !o.explain) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--json goes with --explain");
        return SS_ARGS_BAD;
    }
    if (result == SS_ARGS_RUN && o.no_commands && o.allow_commands) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--no-commands and --allow-commands: give one of them");
        return SS_ARGS_BAD;
    }
    o.realtime = (ss_realtime)realtime;
    o.log_level = (ss_log_level)log_level;
    *out_options = o;
    return result;
}
