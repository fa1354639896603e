/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <stdio.h>
#include <string.h>

#include "bench.h"
#include "rt/plain.h"
#include "rt/program.h"

static const struct {
    const char *name;
    int (*run)(int argc, char **argv);
    char title[32]; /* becomes argv[0], in a copy */
    const char *about;
} reports[] = {
    {"ablation", ss_bench_ablation, "softsim-bench ablation",
     "time and bytes of what a scene's plan leaves out"},
    {"accuracy", ss_bench_accuracy, "softsim-bench accuracy",
     "error against run time of every model, on problems with trusted solutions"},
    {"latency", ss_bench_latency, "softsim-bench latency",
     "pose to force, lateness and missed periods of the whole chain"},
    {"paper", ss_bench_paper, "softsim-bench paper",
     "the figures and tables of a paper, each claim passed or failed"},
    {"scaling", ss_bench_scaling, "softsim-bench scaling",
     "step time, smoothness and energy against the number of nodes"},
    {"stability", ss_bench_stability, "softsim-bench stability",
     "what breaks a model, and whether the program says so"},
};
enum { REPORT_COUNT = sizeof reports / sizeof reports[0] };

static void print_usage(FILE *out)
{
    fprintf(out, "usage: softsim-bench REPORT ...\nMeasures, and writes CSV, pictures and one HTML "
                 "page into a folder.\n\n");
    for (int i = 0; i < REPORT_COUNT; ++i) {
        fprintf(out, "  %-10s %s\n", reports[i].name, reports[i].about);
    }
    fprintf(out,
            "  %-10s prints this\n  %-10s prints the version\n\nsoftsim-bench REPORT --help "
            "lists a report's options.\n",
            "--help", "--version");
}

static int run(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    if (strcmp(name, "--help") == 0) {
        print_usage(stdout);
        return 0;
    }
    if (strcmp(name, "--version") == 0) {
        printf("softsim-bench %s\n", SOFTSIM_VERSION);
        return 0;
    }
    for (int i = 0; i < REPORT_COUNT; ++i) {
        if (strcmp(name, reports[i].name) == 0) {
            char title[sizeof reports[i].title];
            memcpy(title, reports[i].title, sizeof title);
            argv[1] = title;
            return reports[i].run(argc - 1, argv + 1);
        }
    }
    ss_plain_print(stderr,
                   "softsim-bench: '%s' is none of ablation, accuracy, latency, paper, scaling, "
                   "stability; softsim-bench --help says more\n",
                   name);
    return 2;
}

int main(int argc, char **argv)
{
    ss_program_begin();
    return ss_program_finish("softsim-bench", run(argc, argv));
}
