/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The server's status as text: a message must not drive the terminal (rt/plain.h), nor fill it. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "softsim/status.h"

/* What is felt at a probe now, as the newest force says. */
typedef struct ss_show_hand {
    bool is_here; /* a force came within the last half second */
    double force_n;
    double pressed_m; /* how far the surface has been pushed in since the first touch */
    int32_t flags;
} ss_show_hand;

/* One line with the figures that tell health, and what is felt. `hand`: SOFTSIM_MAX_PROBES. */
void ss_show_line(FILE *out, const softsim_server_status *status, const ss_show_hand *hand);
/* A screenful. */
void ss_show_page(FILE *out, const softsim_server_status *status, const ss_show_hand *hand);
