/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The server's report to and from its message, by the list of softsim/status.h. Thread: any. */
#include <stdint.h>

#include "softsim/status.h"
#include "softsim_server_status_t.h"

/* Bytes of the encoded message before `uptime_s`, before `scene`, the type hash included. */
extern const int64_t ss_status_uptime_at, ss_status_texts_at;

/* Texts are borrowed, both ways. */
void ss_status_to_wire(const softsim_server_status *status, softsim_server_status_t *out_wire);
void ss_status_from_wire(const softsim_server_status_t *wire, softsim_server_status *out_status);
