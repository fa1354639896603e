/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What the page is told as text. To be freed; NULL when out of memory. Thread: any. */
#include "softsim/status.h"
#include "softsim/view.h"

char *ss_json_of_status(const softsim_server_status *status);
char *ss_json_of_scene(const softsim_scene_report *scene);
