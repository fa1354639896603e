/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <stdio.h>
#include <string.h>

#include "bench/bench.h"
#include "rt/args.h"
#include "rt/plain.h"
#include "rt/program.h"

static const ss_report_class *const reports[] = {
#define SS_REPORT_ROW(object) &object,
#include "report_rows.h"
#undef SS_REPORT_ROW
};
enum { REPORT_COUNT = sizeof reports / sizeof reports[0] };

static void print_usage(FILE *out)
{
    fprintf(out, "usage: softsim-bench REPORT ...\nMeasures, and writes CSV, pictures and one HTML "
                 "page into a folder.\n\n");
    for (int i = 0; i < REPORT_COUNT; ++i) {
        fprintf(out, "  %-10s %s\n", reports[i]->name, reports[i]->about);
    }
    fprintf(out,
            "  %-10s prints this\n  %-10s prints the version\n\nsoftsim-bench REPORT --help "
            "lists a report's options.\n",
            "--help", "--version");
}

static int run(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    if (ss_args_is_answered("softsim-bench", name, print_usage)) {
        return 0;
    }
    for (int i = 0; i < REPORT_COUNT; ++i) {
        if (strcmp(name, reports[i]->name) == 0) {
            char title[64];
            snprintf(title, sizeof title, "softsim-bench %s", name);
            argv[1] = title;
            return reports[i]->run(argc - 1, argv + 1);
        }
    }
    ss_plain_print(stderr, "softsim-bench: '%s' is no report; there are", name);
    for (int i = 0; i < REPORT_COUNT; ++i) {
        fprintf(stderr, "%s %s", i > 0 ? "," : "", reports[i]->name);
    }
    fprintf(stderr, "; softsim-bench --help says more\n");
    return 2;
}

int main(int argc, char **argv)
{
    ss_program_begin();
    return ss_program_finish("softsim-bench", run(argc, argv));
}
