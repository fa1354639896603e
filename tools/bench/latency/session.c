/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/latency/session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/core/child.h"
#include "process.h"
#include "rt/clock.h"
#include "rt/files.h"
#include "rt/thread.h"
#include "softsim/client.h"

enum { DAEMON, REPLAY, BRIDGE, MONITOR, CHILDREN };
enum { PATH_SIZE = 4096, MAX_WORDS = 64, FIXED_WORDS = 12, LINE_SIZE = 512 };
static const double ready_timeout_s = 120.0; /* a scene's set-up */
static const double force_timeout_s = 20.0;
static const double grace_s = 10.0;
static const int64_t slice_ns = 100000000;
static const char *const program_name[CHILDREN] = {"softsimd", "softsim-replay", "softsim-bridge",
                                                   "softsim-monitor"};

typedef struct chain {
    const ss_session_options *options;
    ss_session *session;
    softsim_error *error;
    softsim_client *client;
    ss_child child[CHILDREN];
    bool is_started[CHILDREN];
    char bin[PATH_SIZE], prefix[32];
    char csv[PATH_SIZE]; /* of the replay, if it were played to its end */
    char out_path[CHILDREN][PATH_SIZE], err_path[CHILDREN][PATH_SIZE];
} chain;

/* ---- statuses ---- */

static void take_status(void *context, const softsim_server_status *from, int64_t receive_ns)
{
    ss_session *session = context;
    if (session->status_count == session->status_capacity) {
        return;
    }
    ss_session_status *to = &session->status[session->status_count++];
    *to = (ss_session_status){.receive_ns = receive_ns, .of = *from};
    to->of.scene = to->of.model = to->of.reason = NULL;
    for (int i = 0; i < SOFTSIM_REFUSED_COUNT; ++i) {
        to->poses_refused += from->poses_refused[i];
    }
    snprintf(to->reason, sizeof to->reason, "%s", from->reason);
}

static int32_t probes_served(const ss_session *session)
{
    int32_t served = 0;
    for (int p = 0; session->status_count > 0 && p < SOFTSIM_MAX_PROBES; ++p) {
        served += session->status[session->status_count - 1].of.probe_periods[p] > 0;
    }
    return served;
}

/* ---- programs ---- */

/* The last line of a log, without its end. */
static void read_last_line(const char *path, char *out, size_t size)
{
    char line[LINE_SIZE];
    FILE *file = fopen(path, "re");
    snprintf(out, size, "it said nothing");
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        line[strcspn(line, "\r\n")] = '\0';
        if (line[0] != '\0') {
            snprintf(out, size, "%s", line);
        }
    }
    if (file != NULL) {
        fclose(file);
    }
}

static softsim_status blame(chain *c, int which, const char *what)
{
    char line[LINE_SIZE];
    read_last_line(c->err_path[which], line, sizeof line);
    softsim_error_add(c->error, SOFTSIM_ERROR_SYSTEM, "%s %s: %s (%s)", program_name[which], what,
                      line, c->err_path[which]);
    return SOFTSIM_ERROR_SYSTEM;
}

static softsim_status fail_stopped(chain *c)
{
    softsim_error_add(c->error, SOFTSIM_ERROR_SYSTEM,
                      "stopped before the end; nothing is reported");
    return SOFTSIM_ERROR_SYSTEM;
}

/* Starts program `which` with the prefix, the LCM address and `count` arguments. */
static softsim_status start(chain *c, int which, const char *const *argument, int32_t count)
{
    char program[PATH_SIZE + 32];
    const char *argv[MAX_WORDS + FIXED_WORDS + 8];
    int32_t used = 0;
    snprintf(program, sizeof program, "%s/%s", c->bin, program_name[which]);
    argv[used++] = program;
    argv[used++] = "--prefix";
    argv[used++] = c->prefix;
    if (c->options->lcm_url != NULL) {
        argv[used++] = "--lcm-url";
        argv[used++] = c->options->lcm_url;
    }
    for (int32_t i = 0; i < count; ++i) {
        argv[used++] = argument[i];
    }
    argv[used] = NULL;
    snprintf(c->out_path[which], PATH_SIZE, "%.3000s/%s.out", c->options->folder,
             program_name[which]);
    snprintf(c->err_path[which], PATH_SIZE, "%.3000s/%s.log", c->options->folder,
             program_name[which]);
    const ss_child_plan plan = {.name = program_name[which],
                                .argv = argv,
                                .out_path = c->out_path[which],
                                .err_path = c->err_path[which],
                                .has_pipe = which == DAEMON};
    const softsim_status status = ss_child_start(&c->child[which], &plan, c->error);
    c->is_started[which] = status == SOFTSIM_OK;
    return status;
}

static softsim_status start_daemon(chain *c)
{
    const char *const arguments[] = {c->options->scene};
    const softsim_status status = start(c, DAEMON, arguments, 1);
    if (status != SOFTSIM_OK) {
        return status;
    }
    if (!ss_child_wait_text(&c->child[DAEMON], "softsimd: ready\n", ready_timeout_s)) {
        if (ss_process_is_stopped()) {
            return fail_stopped(c);
        }
        return blame(c, DAEMON,
                     ss_child_stop(&c->child[DAEMON], grace_s) == 127
                         ? "is not beside softsim-bench"
                         : "did not get ready");
    }
    return SOFTSIM_OK;
}

static softsim_status start_clients(chain *c)
{
    char repeat[24], bridge[PATH_SIZE];
    snprintf(repeat, sizeof repeat, "%lld", (long long)c->options->repeat);
    const char *const replay[] = {"--repeat", repeat, "--csv", c->csv, c->options->poses};
    const char *hand[MAX_WORDS + FIXED_WORDS] = {"--device", "sim", "--probe", "1"};
    enum { OWN_WORDS = 4 };
    snprintf(bridge, sizeof bridge, "%s", c->options->bridge);
    const int32_t words = ss_session_split(bridge, hand + OWN_WORDS, MAX_WORDS);
    if (words < 0 || strlen(c->options->bridge) >= sizeof bridge) {
        softsim_error_add(c->error, SOFTSIM_ERROR_ARGUMENT, "--bridge: more than %d arguments",
                          MAX_WORDS);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    softsim_status status = start(c, REPLAY, replay, 5);
    if (status == SOFTSIM_OK) {
        status = start(c, BRIDGE, hand, OWN_WORDS + words);
    }
    if (status == SOFTSIM_OK) {
        status = start(c, MONITOR, NULL, 0);
    }
    return status;
}

/* Handles what comes for a while; fails when a program has ended or the bench is stopped. */
static softsim_status watch(chain *c, int64_t until_ns)
{
    if (softsim_client_wait(c->client, until_ns) < 0) {
        softsim_error_add(c->error, SOFTSIM_ERROR_NETWORK, "LCM failed");
        return SOFTSIM_ERROR_NETWORK;
    }
    if (ss_process_is_stopped()) {
        return fail_stopped(c);
    }
    for (int i = 0; i < CHILDREN; ++i) {
        if (c->is_started[i] && !ss_child_is_running(&c->child[i])) {
            return blame(c, i, "ended too early");
        }
    }
    return SOFTSIM_OK;
}

static softsim_status wait_for_forces(chain *c)
{
    const int64_t deadline_ns = ss_clock_now_ns() + (int64_t)(1e9 * force_timeout_s);
    while (probes_served(c->session) < 2) {
        const softsim_status status = watch(c, ss_clock_now_ns() + slice_ns);
        if (status != SOFTSIM_OK) {
            return status;
        }
        if (ss_clock_now_ns() > deadline_ns) {
            softsim_error_add(c->error, SOFTSIM_ERROR_SYSTEM,
                              "no forces for two probes within %.0f s; does the scene have tools "
                              "for probes 0 (replay) and 1 (bridge)?",
                              force_timeout_s);
            return SOFTSIM_ERROR_SYSTEM;
        }
    }
    return SOFTSIM_OK;
}

static softsim_status measure(chain *c)
{
    ss_session *session = c->session;
    const double seconds = c->options->seconds;
    softsim_status status =
        ss_bare_start(c->options->lcm_url, c->prefix, seconds, &session->bare_state, c->error);
    const bool is_locked = status == SOFTSIM_OK && ss_thread_lock_memory();
    const bool is_shown = isatty(STDERR_FILENO) == 1;
    (void)is_locked; /* where it is not allowed, the server is late for the same reason */
    session->begin_ns = ss_clock_now_ns();
    session->end_ns = session->begin_ns + (int64_t)(1e9 * seconds);
    int64_t now_ns = session->begin_ns;
    while (status == SOFTSIM_OK && now_ns < session->end_ns) {
        if (is_shown) {
            fprintf(stderr, "\rmeasuring: %.0f of %.0f s ",
                    1e-9 * (double)(now_ns - session->begin_ns), seconds);
        }
        status =
            watch(c, now_ns + slice_ns < session->end_ns ? now_ns + slice_ns : session->end_ns);
        now_ns = ss_clock_now_ns();
    }
    if (is_shown) {
        fprintf(stderr, "\r%40s\r", "");
    }
    if (status == SOFTSIM_OK) {
        ss_bare_stop(session->bare_state, &session->bare);
    }
    return status;
}

/* Clients first, then the server, whose last status is still taken. */
static softsim_status stop_all(chain *c, softsim_status status)
{
    static const int order[CHILDREN] = {REPLAY, BRIDGE, MONITOR, DAEMON};
    for (int i = 0; i < CHILDREN; ++i) {
        const int which = order[i];
        if (!c->is_started[which]) {
            continue;
        }
        const bool was_running = ss_child_is_running(&c->child[which]);
        const int result = ss_child_stop(&c->child[which], grace_s);
        /* The replay has poses for longer; stopped before its end it says so by 1. */
        const bool is_good = which == REPLAY ? was_running && result == 1 : result == 0;
        if (status == SOFTSIM_OK && !is_good) {
            char what[48];
            snprintf(what, sizeof what, "ended with status %d", result);
            status = blame(c, which, what);
        }
    }
    if (c->client != NULL) {
        const int64_t deadline_ns = ss_clock_now_ns() + slice_ns;
        while (softsim_client_wait(c->client, deadline_ns) > 0) {
        }
    }
    return status;
}

softsim_status ss_session_run(const ss_session_options *options, ss_session *session,
                              softsim_error *error)
{
    static chain c; /* large */
    memset(session, 0, sizeof *session);
    c = (chain){.options = options, .session = session, .error = error};
    /* Four a second, and room for a minute of set-up and for those asked for. */
    session->status_capacity = (int32_t)(8.0 * (options->seconds + 120.0));
    session->status = calloc((size_t)session->status_capacity, sizeof *session->status);
    snprintf(c.prefix, sizeof c.prefix, "BENCH_%ld", (long)getpid());
    snprintf(c.csv, sizeof c.csv, "%.3000s/answers.csv", options->folder);
    snprintf(session->answers, sizeof session->answers, "%.3100s" SS_FILES_PART, c.csv);
    if (session->status == NULL || !ss_child_own_folder(c.bin, sizeof c.bin)) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "out of memory, or no /proc");
        return SOFTSIM_ERROR_SYSTEM;
    }
    const softsim_client_config config = {.lcm_url = options->lcm_url,
                                          .prefix = c.prefix,
                                          .context = session,
                                          .handle_status = take_status};
    softsim_status status = softsim_client_open(&config, &c.client, error);
    if (status == SOFTSIM_OK) {
        status = start_daemon(&c);
    }
    if (status == SOFTSIM_OK) {
        status = start_clients(&c);
    }
    if (status == SOFTSIM_OK) {
        status = wait_for_forces(&c);
    }
    if (status == SOFTSIM_OK) {
        status = measure(&c);
    }
    status = stop_all(&c, status);
    softsim_client_close(&c.client);
    return status;
}

void ss_session_fini(ss_session *session)
{
    ss_bare_free(&session->bare_state);
    free(session->status);
    remove(session->answers);
    *session = (ss_session){0};
}

/* ---- arguments for the bridge ---- */

int32_t ss_session_split(char *text, const char **out_word, int32_t capacity)
{
    int32_t count = 0;
    char *rest = NULL;
    for (char *word = strtok_r(text, " \t\r\n", &rest); word != NULL;
         word = strtok_r(NULL, " \t\r\n", &rest)) {
        if (count == capacity) {
            return -1;
        }
        out_word[count++] = word;
    }
    return count;
}

bool ss_session_read_bridge(const char *path, char *out, int32_t size)
{
    static const char suffix[] = "_SECOND";
    char line[4096];
    FILE *file = fopen(path, "re");
    bool is_found = false;
    while (file != NULL && !is_found && fgets(line, sizeof line, file) != NULL) {
        const size_t name = strspn(line, "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
        const size_t tail = sizeof suffix - 1;
        if (name < tail || line[name] != '=' || memcmp(line + name - tail, suffix, tail) != 0) {
            continue;
        }
        const char *value = line + name + 1;
        const char quote = *value == '"' || *value == '\'' ? *value++ : '\0';
        const char ends[] = {quote != '\0' ? quote : ' ', '\n', '\r', '\0'};
        const size_t length = strcspn(value, ends);
        /* Only a plain text: nothing that a shell would expand. */
        is_found = length < (size_t)size && memchr(value, '$', length) == NULL &&
                   memchr(value, '`', length) == NULL && memchr(value, '\\', length) == NULL &&
                   (quote == '\0' || value[length] == quote);
        if (is_found) {
            snprintf(out, (size_t)size, "%.*s", (int)length, value);
        }
    }
    if (file != NULL) {
        fclose(file);
    }
    return is_found;
}
