/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What the page is told as text: JSON, to be freed; NULL when out of memory. Thread: any. */
#include "softsim/status.h"
#include "softsim/view.h"

/* Another number for each start of a server: its clock then, in us. */
int64_t ss_session_of(const softsim_server_status *status);
char *ss_json_of_status(const softsim_server_status *status);
char *ss_json_of_scene(const softsim_scene_report *scene, int64_t session);
