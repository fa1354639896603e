/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A pose path as a device, for tests that need no command line. */
#include "device.h"

softsim_status ss_script_create(const char *csv_path, double period_s, ss_device *out_device,
                                softsim_error *error);
