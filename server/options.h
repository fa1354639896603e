/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* softsimd's command line. Thread: set-up only. */
#include <stdbool.h>

#include "rt/args.h"
#include "rt/thread.h"
#include "softsim/types.h"

typedef enum ss_log_level { SS_LOG_ERROR, SS_LOG_WARNING, SS_LOG_INFO } ss_log_level;

typedef struct ss_options {
    const char *scene_path;
    const char *lcm_url; /* NULL: LCM_DEFAULT_URL, else the local multicast group */
    const char *prefix;
    ss_arg_list set;
    bool check, explain, json, print_config, no_commands, allow_commands, takeover, lockstep, hash;
    double duration_s; /* 0: until told to stop */
    int64_t threads;
    ss_realtime realtime;
    ss_log_level log_level;
} ss_options;

ss_args_result ss_options_parse(int argc, char **argv, ss_options *out_options,
                                softsim_error *error);
