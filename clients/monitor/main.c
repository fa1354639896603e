/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-monitor: the server's state in a terminal, redrawn with every status, and what is felt
 * at each probe, which it hears from the forces; one line a second where the output is no terminal;
 * JSON, one line a status, for programs. --command sends one command instead.
 */
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "command.h"
#include "indentation.h"
#include "process.h"
#include "rt/args.h"
#include "rt/program.h"
#include "rt/vec.h"
#include "show.h"
#include "softsim/client.h"
#include "status_json.h"

static const int64_t patience_ns = 2000000000; /* without a status: the server is gone */
static const int64_t doubt_ns = 1000000000;    /* four statuses: is it? */
static const int64_t give_up_ns = 10000000000; /* --once: no server is coming */
static const int64_t line_ns = 1000000000;
static const int64_t slice_ns = 200000000; /* between looks at the clock and at signals */

static const int64_t fresh_ns = 500000000; /* a force older than this is not felt any more */

typedef struct monitor {
    bool is_json, is_once, is_terminal;
    bool is_done;
    int64_t shown_ns, received_ns; /* 0: never */
    ss_indentation indentation[SOFTSIM_MAX_PROBES];
    ss_show_hand hand[SOFTSIM_MAX_PROBES];
    int64_t felt_ns[SOFTSIM_MAX_PROBES];
} monitor;

static void take_force(void *context, const softsim_force *force, int64_t receive_ns)
{
    monitor *m = context;
    const int32_t p = force->probe;
    if ((force->flags & SOFTSIM_FORCE_OTHER_SENDER) != 0) {
        return; /* whose zero is not what is felt */
    }
    m->felt_ns[p] = receive_ns;
    m->hand[p] =
        (ss_show_hand){.force_n = ss_norm3(force->force),
                       .pressed_m = ss_indentation_take(&m->indentation[p], force, force->proxy),
                       .flags = force->flags};
}

static void take_status(void *context, const softsim_server_status *status, int64_t receive_ns)
{
    monitor *m = context;
    m->received_ns = receive_ns;
    if (m->is_done) {
        return;
    }
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        m->hand[p].is_here = m->felt_ns[p] != 0 && receive_ns - m->felt_ns[p] < fresh_ns;
    }
    if (m->is_json) {
        ss_status_json(stdout, status);
        putchar('\n');
    } else if (m->is_terminal || m->is_once) {
        fputs(m->is_once ? "" : "\033[H\033[J", stdout); /* home, clear below */
        ss_show_page(stdout, status, m->hand);
    } else if (m->shown_ns == 0 || receive_ns - m->shown_ns >= line_ns) {
        ss_show_line(stdout, status, m->hand);
        m->shown_ns = receive_ns;
    }
    fflush(stdout);
    m->is_done = m->is_once;
}

static void say_silent(const char *program, double silent_s)
{
    fprintf(stderr,
            "%s: no status for %.3g s; is softsimd running, with this prefix and LCM url?\n",
            program, silent_s);
}

/* At the end of its time a server in doubt is waited for until it is known to be gone. */
static bool is_over(const monitor *m, int64_t past_ns, double duration_s, int64_t silent_ns)
{
    const bool is_in_doubt =
        m->received_ns != 0 && silent_ns > doubt_ns && silent_ns <= patience_ns;
    return duration_s > 0.0 && (double)past_ns >= 1e9 * duration_s && !is_in_doubt;
}

/* An exit status: failure also when the server was not heard at the end of the time, or more
 * than one server was heard. */
static int watch(const char *program, monitor *m, softsim_client *client, double duration_s)
{
    const int64_t start_ns = softsim_client_now_ns();
    bool is_told = false; /* of this silence */
    bool is_gone = false; /* at the end */
    bool is_changed = false;
    while (!m->is_done && !ss_process_is_stopped()) {
        const int64_t now_ns = softsim_client_now_ns();
        const int64_t silent_ns = now_ns - (m->received_ns != 0 ? m->received_ns : start_ns);
        const bool is_end = is_over(m, now_ns - start_ns, duration_s, silent_ns);
        const bool is_hopeless = m->is_once && silent_ns > give_up_ns;
        is_told = is_told && silent_ns > patience_ns;
        if (!is_told && silent_ns > patience_ns) {
            say_silent(program, 1e-9 * (double)patience_ns);
            is_told = true;
        } else if (!is_told && is_end && m->received_ns == 0) {
            say_silent(program, duration_s);
        }
        if (is_hopeless) {
            fprintf(stderr, "%s: gave up after 10 s\n", program);
        }
        if (is_end || is_hopeless) {
            is_gone = is_told;
            break;
        }
        if (softsim_client_wait(client, now_ns + slice_ns) < 0) {
            fprintf(stderr, "%s: LCM failed\n", program);
            return EXIT_FAILURE;
        }
        ss_process_tell_two(program, "the first is shown", softsim_client_hears_two(client));
        if (!is_changed && softsim_client_server_changes(client) > 0) {
            fprintf(stderr, "%s: another server answers, and is shown from now on\n", program);
            is_changed = true;
        }
        if (ferror(stdout)) {
            return EXIT_FAILURE; /* ss_program_finish says why */
        }
    }
    const bool is_one = !ss_process_tell_two(program, "", false);
    return m->received_ns != 0 && !is_gone && is_one && !is_changed ? EXIT_SUCCESS : EXIT_FAILURE;
}

int main(int argc, char **argv)
{
    monitor m = {.is_terminal = isatty(STDOUT_FILENO) == 1};
    double duration_s = 0.0;
    const char *command = NULL;
    softsim_client_config config = {.context = &m, .handle_status = take_status, .hears_all = true};
    const ss_arg rows[] = {
        SS_FLAG("--once", &m.is_once, "show one status and end"),
        SS_FLAG("--json", &m.is_json, "one line of JSON a status"),
        {"--duration", SS_ARG_NUMBER, &duration_s, 1e-3, 1e6, "S",
         "ends after S; exit status 1 if the server is silent by then"},
        SS_TEXT(
            "--command", &command, "'NAME[ ARGUMENT]'",
            "sends reset, pause, resume, refresh, status, shutdown or 'set PATH=VALUE', prints the "
            "reply"),
        SS_ARG_BUS(&config.lcm_url, &config.prefix),
    };
    softsim_error error = {.status = SOFTSIM_OK};
    const char *program = program_invocation_short_name;
    ss_program_begin();
    const ss_args_result parsed =
        SS_ARGS_OPTIONS(argc, argv, "[options]",
                        "Shows the state of a softsimd, or sends it a command.", rows, &error);
    if (parsed == SS_ARGS_DONE) {
        return ss_program_finish(program, EXIT_SUCCESS);
    }
    ss_args_result checked = parsed;
    if (parsed == SS_ARGS_RUN && command && (m.is_once || m.is_json || duration_s > 0.0)) {
        softsim_error_add(&error, SOFTSIM_ERROR_ARGUMENT,
                          "--command shows no status; leave --once, --json and --duration out");
        checked = SS_ARGS_BAD;
    }
    softsim_client *client = NULL;
    config.handle_force = m.is_json ? NULL : take_force;
    ss_process_catch_stop();
    if (checked == SS_ARGS_RUN && command) {
        return ss_program_finish(program, ss_command_run(program, &config, command));
    }
    if (checked == SS_ARGS_BAD || softsim_client_open(&config, &client, &error) != SOFTSIM_OK) {
        return ss_args_finish(program, error.status, &error);
    }
    const int status = watch(program, &m, client, duration_s);
    softsim_client_close(&client);
    return ss_program_finish(program, status);
}
