/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/args.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *program_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static void print_help(const char *program, const char *usage, const char *about,
                       const ss_arg *rows, int32_t row_count)
{
    printf("usage: %s %s\n%s\n\n", program, usage, about);
    for (int32_t i = 0; i < row_count; ++i) {
        char left[96];
        snprintf(left, sizeof left, "%s%s%s", rows[i].name, rows[i].kind == SS_ARG_FLAG ? "" : " ",
                 rows[i].kind == SS_ARG_FLAG ? "" : rows[i].value);
        printf("  %-34s ", left);
        for (const char *at = rows[i].help; *at != '\0';) {
            const size_t length = strcspn(at, "\n");
            printf("%*s%.*s\n", at == rows[i].help ? 0 : 37, "", (int)length, at);
            at += length + (at[length] == '\n');
        }
    }
    printf("  %-34s %s\n  %-34s %s\n", "--help", "prints this", "--version", "prints the version");
}

static int32_t find_choice(const char *choices, const char *text)
{
    const size_t length = strlen(text);
    int32_t index = 0;
    for (const char *at = choices; *at;) {
        const size_t span = strcspn(at, "|");
        if (span == length && memcmp(at, text, span) == 0) {
            return index;
        }
        at += span + (at[span] == '|');
        ++index;
    }
    return -1;
}

/* Reads a whole number or a finite real within the row's bounds. */
static bool parse_number(const ss_arg *row, const char *text, double *out, softsim_error *error)
{
    char *end = NULL;
    errno = 0;
    const double value = strtod(text, &end);
    if (end == text || *end != '\0' || !isfinite(value) || errno == ERANGE ||
        (row->kind == SS_ARG_INTEGER && floor(value) != value)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s: '%s' is not %s; give %s", row->name,
                          text, row->kind == SS_ARG_INTEGER ? "a whole number" : "a number",
                          row->value);
        return false;
    }
    if (value < row->min || value > row->max) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s: %g is out of range; give %g to %g",
                          row->name, value, row->min, row->max);
        return false;
    }
    *out = value;
    return true;
}

static void store(const ss_arg *row, const char *text, softsim_error *error)
{
    double number = 0.0;
    switch (row->kind) {
    case SS_ARG_FLAG:
        *(bool *)row->out = true;
        break;
    case SS_ARG_STRING:
        *(const char **)row->out = text;
        break;
    case SS_ARG_NUMBER:
        if (parse_number(row, text, &number, error)) {
            *(double *)row->out = number;
        }
        break;
    case SS_ARG_INTEGER:
        if (parse_number(row, text, &number, error)) {
            *(int64_t *)row->out = (int64_t)number;
        }
        break;
    case SS_ARG_CHOICE: {
        const int32_t index = find_choice(row->value, text);
        if (index < 0) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s: '%s' is not one of %s", row->name,
                              text, row->value);
        } else {
            *(int32_t *)row->out = index;
        }
        break;
    }
    case SS_ARG_LIST: {
        ss_arg_list *list = row->out;
        if (list->count == SS_ARG_LIST_MAX) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s: given more than %d times",
                              row->name, SS_ARG_LIST_MAX);
        } else {
            list->value[list->count++] = text;
        }
        break;
    }
    }
}

ss_args_result ss_args_parse(int argc, char **argv, const char *usage, const char *about,
                             const ss_arg *rows, int32_t row_count, const char **positional,
                             int32_t positional_min, int32_t positional_max,
                             int32_t *out_positional_count, softsim_error *error)
{
    const char *program = program_name(argv[0]);
    int32_t count = 0;
    const char *surplus = NULL;
    bool only_positional = false;
    for (int i = 1; i < argc; ++i) {
        const char *text = argv[i];
        if (only_positional || text[0] != '-' || text[1] == '\0') {
            if (count < positional_max) {
                positional[count] = text;
            } else if (count == positional_max) {
                surplus = text;
            }
            ++count;
            continue;
        }
        if (strcmp(text, "--") == 0) {
            only_positional = true;
            continue;
        }
        if (strcmp(text, "--help") == 0) {
            print_help(program, usage, about, rows, row_count);
            return SS_ARGS_DONE;
        }
        if (strcmp(text, "--version") == 0) {
            printf("%s %s\n", program, SOFTSIM_VERSION);
            return SS_ARGS_DONE;
        }
        const size_t span = strcspn(text, "=");
        const ss_arg *row = NULL;
        for (int32_t k = 0; k < row_count && !row; ++k) {
            row = strlen(rows[k].name) == span && memcmp(rows[k].name, text, span) == 0 ? &rows[k]
                                                                                        : NULL;
        }
        const char *value = text[span] == '=' ? text + span + 1 : NULL;
        if (!row) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "unknown option '%s'; %s --help lists the options", text, program);
        } else if (row->kind == SS_ARG_FLAG && value) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s takes no value", row->name);
        } else if (row->kind == SS_ARG_FLAG || value || i + 1 < argc) {
            store(row, row->kind == SS_ARG_FLAG || value ? value : argv[++i], error);
        } else {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s needs a value: %s", row->name,
                              row->value);
        }
    }
    /* What stands alone is counted only when every option was understood: the value of an unknown
     * option would count, and an option without a value has taken its neighbour. */
    if (error->fault_count == 0 && surplus) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "'%s' is one argument too many; usage: %s %s", surplus, program, usage);
    } else if (error->fault_count == 0 && count < positional_min) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "something is missing; usage: %s %s",
                          program, usage);
    }
    if (out_positional_count != NULL) {
        *out_positional_count = count < positional_max ? count : positional_max;
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : SS_ARGS_RUN;
}

/* Does the line hold nothing but a caret under a place? */
static bool is_caret(const char *line, size_t length)
{
    const size_t blank = strspn(line, " \t");
    return blank < length && blank + strspn(line + blank, "^~") == length;
}

void ss_args_print_error(const char *program, const softsim_error *error)
{
    program = program_name(program);
    const char *at = error->text;
    while (*at) {
        const size_t length = strcspn(at, "\n");
        const char *next = at + length + (at[length] == '\n');
        /* A quoted line of a file and the caret under it stand as they are. */
        const bool is_quote = is_caret(at, length) || is_caret(next, strcspn(next, "\n"));
        fprintf(stderr, "%s%s%.*s\n", is_quote ? "" : program, is_quote ? "" : ": ", (int)length,
                at);
        at = next;
    }
}

bool ss_args_may_run(const char *program, ss_args_result result, const softsim_error *error,
                     int *out_exit)
{
    if (result == SS_ARGS_BAD) {
        ss_args_print_error(program, error);
    }
    *out_exit = result == SS_ARGS_BAD ? SS_EXIT_BAD_INPUT : 0;
    return result == SS_ARGS_RUN;
}

int ss_args_finish(const char *program, softsim_status status, const softsim_error *error)
{
    if (status == SOFTSIM_OK) {
        return EXIT_SUCCESS;
    }
    ss_args_print_error(program, error);
    return status == SOFTSIM_ERROR_ARGUMENT ? SS_EXIT_BAD_INPUT : EXIT_FAILURE;
}

bool ss_args_is_answered(const char *program, const char *command, void (*usage)(FILE *out))
{
    const bool is_help = strcmp(command, "--help") == 0;
    const bool is_version = strcmp(command, "--version") == 0;
    if (is_help) {
        usage(stdout);
    } else if (is_version) {
        printf("%s %s\n", program, SOFTSIM_VERSION);
    }
    return is_help || is_version;
}
