/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Command lines: one row per option gives parsing, range errors and --help. `--name value` and
 * `--name=value` are both read; every fault is added to the error in one go, without those that
 * only follow from another; --help and --version print to stdout. Thread: set-up only.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "softsim/types.h"

typedef enum ss_arg_kind {
    SS_ARG_FLAG,    /* bool: set to true */
    SS_ARG_STRING,  /* const char * */
    SS_ARG_NUMBER,  /* double within min..max */
    SS_ARG_INTEGER, /* int64_t within min..max */
    SS_ARG_CHOICE,  /* int32_t: index into `choices` "a|b|c" */
    SS_ARG_LIST     /* ss_arg_list: may be given again and again */
} ss_arg_kind;

enum { SS_ARG_LIST_MAX = 64 };
typedef struct ss_arg_list {
    const char *value[SS_ARG_LIST_MAX];
    int32_t count;
} ss_arg_list;

typedef struct ss_arg {
    const char *name; /* "--duration" */
    ss_arg_kind kind;
    void *out;
    double min, max;   /* NUMBER and INTEGER, inclusive */
    const char *value; /* how --help names the value, or the choices "a|b|c" */
    const char *help;  /* each of its lines stands below the first */
} ss_arg;

/* Rows of the kinds without a range. */
#define SS_ARG_ROW(name, kind, at, value, help)                                                    \
    {                                                                                              \
        (name), (kind), (at), 0, 0, (value), (help)                                                \
    }
#define SS_FLAG(name, at, help)          SS_ARG_ROW(name, SS_ARG_FLAG, at, "", help)
#define SS_TEXT(name, at, value, help)   SS_ARG_ROW(name, SS_ARG_STRING, at, value, help)
#define SS_LIST(name, at, value, help)   SS_ARG_ROW(name, SS_ARG_LIST, at, value, help)
#define SS_CHOICE(name, at, value, help) SS_ARG_ROW(name, SS_ARG_CHOICE, at, value, help)

/* The row of a client's LCM network, and with that of its channels. */
#define SS_ARG_LCM_URL(at)                                                                         \
    SS_TEXT("--lcm-url", (at), "URL", "LCM network (LCM_DEFAULT_URL, else local multicast)")
#define SS_ARG_BUS(url_at, prefix_at)                                                              \
    SS_ARG_LCM_URL(url_at), SS_TEXT("--prefix", (prefix_at), "NAME", "of the channels (SOFTSIM)")

typedef enum ss_args_result { SS_ARGS_RUN, SS_ARGS_DONE, SS_ARGS_BAD } ss_args_result;

/* `usage` is the line after the program's name ("[options] SCENE.yaml"), `about` one sentence.
 * Positional arguments go to `positional`, at least `positional_min` and at most `positional_max`;
 * where there may be none it and `out_positional_count` may be NULL.
 * SS_ARGS_DONE after --help or --version; SS_ARGS_BAD with the faults in `error`. */
ss_args_result ss_args_parse(int argc, char **argv, const char *usage, const char *about,
                             const ss_arg *rows, int32_t row_count, const char **positional,
                             int32_t positional_min, int32_t positional_max,
                             int32_t *out_positional_count, softsim_error *error);

/* Of a program that takes options alone; `rows` is the array. */
#define SS_ARGS_OPTIONS(argc, argv, usage, about, rows, error)                                     \
    ss_args_parse((argc), (argv), (usage), (about), (rows),                                        \
                  (int32_t)(sizeof(rows) / sizeof(rows)[0]), NULL, 0, 0, NULL, (error))

/* What was asked for cannot be done, as against EXIT_FAILURE: it was tried. */
enum { SS_EXIT_BAD_INPUT = 2 };

/* True: run. Else *out_exit is the program's: 0 after SS_ARGS_DONE, SS_EXIT_BAD_INPUT after
 * SS_ARGS_BAD, whose faults it prints. */
bool ss_args_may_run(const char *program, ss_args_result result, const softsim_error *error,
                     int *out_exit);

/* The program's exit status after its work: prints the faults where `status` is not OK, and tells
 * what cannot be asked for (SOFTSIM_ERROR_ARGUMENT) from what failed. */
int ss_args_finish(const char *program, softsim_status status, const softsim_error *error);

/* Of a program of commands: answers --help (by `usage`) and --version in a command's place. */
bool ss_args_is_answered(const char *program, const char *command, void (*usage)(FILE *out));

/* Prints `error` to stderr, one line per fault with the program's name before it; a quoted line of
 * a file and its caret follow as they are. */
void ss_args_print_error(const char *program, const softsim_error *error);
