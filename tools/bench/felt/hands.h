/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * softsim-bench felt --hands: every simulated hand in closed loop with tissue, at several delays of
 * the bus: energy that it is given, chatter, what the stiffness limit and the damping did. Thread:
 * main.
 */
/* As ss_report_class.run; one of the arguments is --hands. */
int ss_felt_hands(int argc, char **argv);
