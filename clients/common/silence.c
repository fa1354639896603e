/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "silence.h"

#include <inttypes.h>
#include <stdio.h>

#include "process.h"

static const int64_t patience_ns = 1000000000; /* statuses come four times a second */

typedef struct heard {
    bool is_any;
    int64_t wrong_probe;
} heard;

static void take_status(void *context, const softsim_server_status *status, int64_t receive_ns)
{
    (void)receive_ns;
    heard *h = context;
    h->is_any = true;
    h->wrong_probe = status->poses_refused[SOFTSIM_REFUSED_WRONG_PROBE];
}

void ss_silence_explain(const char *program, const softsim_client_config *config, int32_t probe,
                        const char *what)
{
    heard h = {.is_any = false};
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_client *client = NULL;
    const softsim_client_config listening = {.lcm_url = config->lcm_url,
                                             .prefix = config->prefix,
                                             .context = &h,
                                             .handle_status = take_status};
    if (softsim_client_open(&listening, &client, &error) == SOFTSIM_OK) {
        const int64_t deadline_ns = softsim_client_now_ns() + patience_ns;
        while (!h.is_any && !ss_process_is_stopped() && softsim_client_now_ns() < deadline_ns &&
               softsim_client_wait(client, deadline_ns) >= 0) {
        }
    }
    softsim_client_close(&client);
    char name[16] = "";
    if (probe >= 0) {
        snprintf(name, sizeof name, " %" PRId32, probe);
    }
    if (!h.is_any) {
        fprintf(stderr, "%s: %s; is softsimd running, with this prefix, LCM url and probe?\n",
                program, what);
    } else if (h.wrong_probe > 0) {
        fprintf(stderr,
                "%s: %s: the server has refused %" PRId64
                " poses (wrong probe); has its scene a tool for probe%s, under contact.tools?\n",
                program, what, h.wrong_probe, name);
    } else {
        fprintf(stderr,
                "%s: %s, though a server answers on this prefix; softsim-monitor shows what it "
                "refuses\n",
                program, what);
    }
}
