/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * softsim-bench felt --hands: every simulated hand in closed loop with tissue, at several delays of
 * the bus: energy that it is given, chatter, what the stiffness limit and the damping did. Thread:
 * main.
 */
#include <stdint.h>

/* As ss_report_class.run; one of the arguments is --hands. */
int ss_felt_hands(int argc, char **argv);
/* Numbers with commas between them into out[most]; their count, -1 when one is none, out of range
 * or beyond `most`. */
int32_t ss_felt_numbers(const char *text, double low, double high, int32_t most, double *out);
