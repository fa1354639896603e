/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "leftover.h"

#include <signal.h>
#include <stddef.h>
#include <unistd.h>

static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
enum { NUMBERS = sizeof numbers / sizeof *numbers };

/* Changed only while the signals wait. */
static const char *volatile watched[LEFTOVER_MAX];

/* Calls only what a handler may. SA_RESETHAND: the signal then does what it does without one. */
static void remove_all(int number)
{
    for (int i = 0; i < LEFTOVER_MAX; ++i) {
        if (watched[i] != NULL) {
            (void)unlink(watched[i]);
        }
    }
    (void)raise(number);
}

static sigset_t hold_signals(void)
{
    sigset_t set, before;
    (void)sigemptyset(&set);
    for (int i = 0; i < NUMBERS; ++i) {
        (void)sigaddset(&set, numbers[i]);
    }
    (void)sigprocmask(SIG_BLOCK, &set, &before);
    return before;
}

static void let_signals(sigset_t before)
{
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
}

/* `now` in the place of `before`. */
static void change(const char *before, const char *now)
{
    for (int i = 0; i < LEFTOVER_MAX; ++i) {
        if (watched[i] == before) {
            watched[i] = now;
            return;
        }
    }
}

static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = remove_all, .sa_flags = (int)SA_RESETHAND};
    (void)sigemptyset(&action.sa_mask);
    for (int i = 0; i < NUMBERS; ++i) {
        struct sigaction before;
        if (sigaction(numbers[i], NULL, &before) == 0 && before.sa_handler != SIG_IGN) {
            (void)sigaction(numbers[i], &action, NULL);
        }
    }
}

softsim_status leftover_open(ss_output *output, const char *path, softsim_error *error)
{
    const sigset_t before = hold_signals();
    const softsim_status status = ss_output_open(output, path, error);
    if (status == SOFTSIM_OK) {
        change(NULL, output->temporary);
        catch_signals();
    }
    let_signals(before);
    return status;
}

softsim_status leftover_commit(ss_output *output, softsim_error *error)
{
    const sigset_t before = hold_signals();
    change(output->temporary, NULL);
    const softsim_status status = ss_output_commit(output, error);
    let_signals(before);
    return status;
}

void leftover_abandon(ss_output *output)
{
    const sigset_t before = hold_signals();
    change(output->temporary, NULL);
    ss_output_abandon(output);
    let_signals(before);
}
