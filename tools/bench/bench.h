/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The reports of softsim-bench. argv[0] is "softsim-bench REPORT"; each returns the program's exit
 * status. Thread: main.
 */

/* Error against run time of every model, on problems with trusted solutions. */
int ss_bench_accuracy(int argc, char **argv);
/* The whole chain against a bare timer loop and a bare LCM echo in the same run; or, with --log,
 * how a session felt. */
int ss_bench_latency(int argc, char **argv);
/* The figures and tables of a paper, claim by claim. */
int ss_bench_paper(int argc, char **argv);
/* Step time, smoothness and energy against the number of nodes. */
int ss_bench_scaling(int argc, char **argv);
