/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The daemon's threads: net (LCM in and out), simulation, haptic, publish. Each runs one piece of
 * the world's work; nothing else creates a thread in real time. In lockstep the net thread alone
 * moves the world.
 */
#include "options.h"
#include "world/world.h"

/* Runs until a signal, `--duration`, the command `shutdown` or a broken network. Prints
 * `softsimd: ready` when it listens. SOFTSIM_OK, or what stopped it with the reason in `error`.
 * Thread: main, which must have blocked SIGINT and SIGTERM. */
softsim_status ss_loops_run(ss_world *world, const ss_options *options, softsim_error *error);
