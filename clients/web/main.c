/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-web: the deforming body, the tools and the forces in a browser, whose mouse is a probe.
 */
#include <arpa/inet.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hub.h"
#include "process.h"
#include "rt/args.h"
#include "rt/program.h"
#include "serve.h"

typedef struct options {
    const char *host, *token, *record_dir, *lcm_url, *prefix;
    int64_t port;
    double duration_s;
} options;

static bool is_loopback(const char *host)
{
    return strncmp(host, "127.", 4) == 0;
}

/* Names what is wrong; `localhost` becomes an address. */
static bool check(options *o, softsim_error *error)
{
    struct in_addr address;
    struct stat found;
    if (strcmp(o->host, "localhost") == 0) {
        o->host = "127.0.0.1";
    }
    if (inet_pton(AF_INET, o->host, &address) != 1) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--host %.60s: give an IPv4 address of this machine, such as 127.0.0.1",
                          o->host);
    } else if (!is_loopback(o->host) && o->token == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--host %s: whoever reaches it could move the tool; give --token T, "
                          "which the address in the browser then needs",
                          o->host);
    }
    if (o->token != NULL && (strlen(o->token) < 8 || strlen(o->token) > 100 ||
                             strspn(o->token, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                              "0123456789-_") != strlen(o->token))) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--token: give 8 to 100 characters of A-Z a-z 0-9 - _");
    }
    if (o->record_dir != NULL && (stat(o->record_dir, &found) != 0 || !S_ISDIR(found.st_mode) ||
                                  access(o->record_dir, W_OK) != 0)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--record-dir %.200s: not a folder that can be written to; make it first",
                          o->record_dir);
    }
    return error->fault_count == 0;
}

/* Until a signal, the end of its time, or a failure. */
static int serve_on(const char *program, ss_serve *serve, ss_hub *hub, double duration_s)
{
    const int64_t start_ns = softsim_client_now_ns();
    while (!ss_process_is_stopped() &&
           (duration_s <= 0.0 || (double)(softsim_client_now_ns() - start_ns) < 1e9 * duration_s)) {
        if (ss_hub_is_broken(hub)) {
            fprintf(stderr, "%s: LCM failed; check the network and start again\n", program);
            return EXIT_FAILURE;
        }
        if (!ss_serve_run(serve)) {
            fprintf(stderr, "%s: the web server failed\n", program);
            return EXIT_FAILURE;
        }
    }
    return EXIT_SUCCESS;
}

int main(int argc, char **argv)
{
    options o = {.host = "127.0.0.1", .port = 8080};
    const ss_arg rows[] = {
        {"--port", SS_ARG_INTEGER, &o.port, 0, 65535, "N", "to listen on (8080); 0: a free one"},
        SS_TEXT("--host", &o.host, "ADDRESS",
                "to listen on (127.0.0.1: this machine only); another needs --token"),
        SS_TEXT("--token", &o.token, "T", "who has it not in the address (/?token=T) is refused"),
        SS_TEXT("--record-dir", &o.record_dir, "DIR",
                "where recordings stay (a folder that is removed at the end)"),
        {"--duration", SS_ARG_NUMBER, &o.duration_s, 1e-3, 1e6, "S", "ends after S"},
        SS_ARG_BUS(&o.lcm_url, &o.prefix),
    };
    softsim_error error = {.status = SOFTSIM_OK};
    const char *program = program_invocation_short_name;
    ss_program_begin();
    ss_args_result parsed =
        SS_ARGS_OPTIONS(argc, argv, "[options]",
                        "Shows a softsimd in a browser, whose mouse is a probe.", rows, &error);
    parsed = parsed == SS_ARGS_RUN && !check(&o, &error) ? SS_ARGS_BAD : parsed;
    int exit_code = 0;
    if (!ss_args_may_run(program, parsed, &error, &exit_code)) {
        return ss_program_finish(program, exit_code);
    }
    char folder[] = "/tmp/softsim-web-XXXXXX";
    const bool is_own_folder = o.record_dir == NULL && mkdtemp(folder) != NULL;
    ss_serve *serve = NULL;
    ss_hub *hub = NULL;
    const ss_serve_config serve_config = {
        .host = o.host, .port = (int32_t)o.port, .token = o.token};
    ss_hub_config hub_config = {.lcm_url = o.lcm_url,
                                .prefix = o.prefix,
                                .record_dir = o.record_dir != NULL ? o.record_dir : folder,
                                .is_temporary = o.record_dir == NULL,
                                .wake = ss_serve_wake};
    int result = EXIT_FAILURE;
    ss_process_catch_stop();
    softsim_status status = ss_serve_open(&serve_config, &serve, &error);
    hub_config.context = serve;
    if (status == SOFTSIM_OK) {
        status = ss_hub_open(&hub_config, &hub, &error);
    }
    if (status == SOFTSIM_OK) {
        ss_serve_attach(serve, hub);
        fprintf(stderr, "%s: open http://%s:%d/%s%s in a browser\n", program,
                strcmp(o.host, "0.0.0.0") == 0 ? "this machine's address" : o.host,
                ss_serve_port(serve), o.token != NULL ? "?token=" : "",
                o.token != NULL ? o.token : "");
        result = serve_on(program, serve, hub, o.duration_s);
    }
    ss_hub_stop(hub);       /* its thread wakes the other */
    ss_serve_close(&serve); /* its browsers are forgotten by the hub */
    ss_hub_close(&hub, &error);
    if (is_own_folder) {
        rmdir(folder); /* it stays with a recording that could not be finished */
    }
    return error.fault_count > 0 ? ss_args_finish(program, error.status, &error)
                                 : ss_program_finish(program, result);
}
