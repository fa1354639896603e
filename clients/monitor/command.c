/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "process.h"
#include "rt/args.h"
#include "rt/plain.h"

enum { NAME_SIZE = 64 };
static const int64_t patience_ns = 3000000000; /* a server replies within milliseconds */

typedef struct answer {
    int32_t id;
    int32_t code;
    bool is_here;
} answer;

static void take_reply(void *context, int32_t id, int32_t code, const char *text)
{
    answer *a = context;
    if (id == a->id && !a->is_here) {
        a->is_here = true;
        a->code = code;
        ss_plain_print(stdout, "%s\n", text);
    }
}

/* Waits for the reply. An exit status. */
static int await(const char *program, softsim_client *client, answer *a)
{
    const int64_t deadline_ns = softsim_client_now_ns() + patience_ns;
    while (!a->is_here && !ss_process_is_stopped()) {
        if (softsim_client_now_ns() >= deadline_ns) {
            fprintf(stderr,
                    "%s: no reply for 3 s; is softsimd running, with this prefix and LCM url?\n",
                    program);
            return EXIT_FAILURE;
        }
        if (softsim_client_wait(client, deadline_ns) < 0) {
            fprintf(stderr, "%s: LCM failed\n", program);
            return EXIT_FAILURE;
        }
    }
    if (!a->is_here) {
        return EXIT_FAILURE;
    }
    return a->code == 0 ? EXIT_SUCCESS : a->code == 1 ? EXIT_FAILURE : SS_EXIT_BAD_INPUT;
}

int ss_command_run(const char *program, const softsim_client_config *config, const char *text)
{
    char name[NAME_SIZE];
    answer a = {.id = 0};
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_client *client = NULL;
    const softsim_client_config asking = {.lcm_url = config->lcm_url,
                                          .prefix = config->prefix,
                                          .context = &a,
                                          .handle_reply = take_reply};
    const char *begin = text + strspn(text, " ");
    const size_t length = strcspn(begin, " ");
    const char *argument = begin + length + strspn(begin + length, " ");
    snprintf(name, sizeof name, "%.*s", (int)(length < NAME_SIZE ? length : NAME_SIZE - 1), begin);
    if (softsim_client_open(&asking, &client, &error) != SOFTSIM_OK) {
        return ss_args_finish(program, error.status, &error);
    }
    int status = SS_EXIT_BAD_INPUT;
    a.id = softsim_client_send_command(client, name, argument);
    if (a.id != 0) {
        status = await(program, client, &a);
    } else {
        fprintf(stderr,
                "%s: --command: give NAME or 'NAME ARGUMENT', such as pause or 'set "
                "haptic.max_force_n=5'\n",
                program);
    }
    softsim_client_close(&client);
    return status;
}
