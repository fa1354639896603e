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
        {"--lcm-url", SS_ARG_STRING, &o.lcm_url, 0, 0, "URL",
         "LCM provider (default: LCM_DEFAULT_URL, else local multicast, ttl 0)"},
        {"--prefix", SS_ARG_STRING, &o.prefix, 0, 0, "NAME", "channel prefix (default SOFTSIM)"},
        {"--set", SS_ARG_LIST, &o.set, 0, 0, "PATH=VALUE", "overrides one scene value"},
        {"--check", SS_ARG_FLAG, &o.check, 0, 0, "",
         "loads, plans and exits: 0 good, 1 usable with warnings, 2 unusable; opens no LCM"},
        {"--explain", SS_ARG_FLAG, &o.explain, 0, 0, "",
         "prints what this scene uses and what is left out, and exits"},
        {"--json", SS_ARG_FLAG, &o.json, 0, 0, "",
         "with --explain: as one object of JSON, with bytes, threads and warnings"},
        {"--print-config", SS_ARG_FLAG, &o.print_config, 0, 0, "",
         "prints the effective scene values and exits"},
        {"--duration", SS_ARG_NUMBER, &o.duration_s, 1e-6, 1e9, "S",
         "ends S seconds after ready (simulated seconds in lockstep)"},
        {"--no-commands", SS_ARG_FLAG, &o.no_commands, 0, 0, "",
         "refuses every command but refresh and status (default with an LCM URL of your own)"},
        {"--allow-commands", SS_ARG_FLAG, &o.allow_commands, 0, 0, "",
         "takes every command (default without an LCM URL of your own)"},
        {"--takeover", SS_ARG_FLAG, &o.takeover, 0, 0, "",
         "ends the server that answers on the prefix and takes its place; without it this one "
         "refuses to start"},
        {"--realtime", SS_ARG_CHOICE, &realtime, 0, 0, "auto|fifo|off",
         "SCHED_FIFO for the loops: where allowed, always, never (default auto)"},
        {"--threads", SS_ARG_INTEGER, &o.threads, 1, 64, "N",
         "threads for set-up and workers (default 1); results do not depend on it"},
        {"--lockstep", SS_ARG_FLAG, &o.lockstep, 0, 0, "",
         "one haptic tick per pose received, nothing else moves time"},
        {"--hash", SS_ARG_FLAG, &o.hash, 0, 0, "",
         "prints the final state hash as the last line of stdout"},
        {"--log-level", SS_ARG_CHOICE, &log_level, 0, 0, "error|warning|info",
         "what stderr tells (default info)"},
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
