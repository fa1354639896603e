/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "leftover.h"

#include <signal.h>
#include <stddef.h>
#include <unistd.h>

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

void leftover_watch(const char *path)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    for (int i = 0; i < LEFTOVER_MAX; ++i) {
        if (watched[i] == NULL) {
            watched[i] = path;
            break;
        }
    }
    struct sigaction action = {.sa_handler = remove_all, .sa_flags = (int)SA_RESETHAND};
    (void)sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
        struct sigaction before;
        if (sigaction(numbers[i], NULL, &before) == 0 && before.sa_handler != SIG_IGN) {
            (void)sigaction(numbers[i], &action, NULL);
        }
    }
}

void leftover_forget(const char *path)
{
    for (int i = 0; i < LEFTOVER_MAX; ++i) {
        watched[i] = watched[i] == path ? NULL : watched[i];
    }
}
