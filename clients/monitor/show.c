/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "show.h"

#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "rt/plain.h"

/* ---- fields ---- */

typedef enum field_type { TYPE_int32_t, TYPE_int64_t, TYPE_double, TYPE_text } field_type;

/* One of a status, as softsim/status.h lists them. */
typedef struct field {
    const char *name;
    field_type type;
    int count; /* of an array; 0: a scalar */
    size_t at; /* bytes into the struct */
    const char *line, *text;
} field;

static const field fields[] = {
#define SCALAR(type, name, line, text)                                                             \
    {#name, TYPE_##type, 0, offsetof(softsim_server_status, name), line, text},
#define ARRAY(type, name, count, line, text)                                                       \
    {#name, TYPE_##type, count, offsetof(softsim_server_status, name), line, text},
#define TEXT(name, line) {#name, TYPE_text, 0, offsetof(softsim_server_status, name), line, ""},
    SOFTSIM_SERVER_STATUS_LIST(SCALAR, ARRAY, TEXT)
#undef SCALAR
#undef ARRAY
#undef TEXT
};
enum { FIELD_COUNT = sizeof fields / sizeof *fields };

/* Element `i` of a field; only the one that its type says is to be read. */
typedef struct value {
    int64_t integer;
    double number;
    const char *text;
} value;

static value read_field(const softsim_server_status *s, const field *f, int i)
{
    const char *at = (const char *)s + f->at;
    int32_t integer = 0;
    value v = {0, 0.0, ""};
    switch (f->type) {
    case TYPE_int32_t:
        memcpy(&integer, at + (size_t)i * sizeof integer, sizeof integer);
        v.integer = integer;
        break;
    case TYPE_int64_t:
        memcpy(&v.integer, at + (size_t)i * sizeof v.integer, sizeof v.integer);
        break;
    case TYPE_double:
        memcpy(&v.number, at + (size_t)i * sizeof v.number, sizeof v.number);
        break;
    case TYPE_text:
        memcpy(&v.text, at, sizeof v.text);
        break;
    }
    return v;
}

/* ---- for people ---- */

/* A figure of a message: whatever a stranger says, no longer than a column. */
typedef struct figure {
    char text[32];
} figure;

static figure fixed(double number, int decimals)
{
    figure f;
    (void)snprintf(f.text, sizeof f.text, fabs(number) < 1e12 ? "%.*f" : "%.*g", decimals, number);
    return f;
}

static figure short_number(double number)
{
    figure f;
    (void)snprintf(f.text, sizeof f.text, "%.3g", number);
    return f;
}

static figure seconds(double number)
{
    figure f;
    (void)snprintf(f.text, sizeof f.text, "%.3g s", number);
    return f;
}

static figure whole(int64_t number)
{
    figure f;
    (void)snprintf(f.text, sizeof f.text, "%" PRId64, number);
    return f;
}

/* As the letter of softsim/status.h says. */
static figure format(char letter, const value *v)
{
    switch (letter) {
    case 'd':
        return whole(v->integer);
    case 'n':
        return v->integer >= 0 ? whole(v->integer) : (figure){"none"};
    case 'M':
        return fixed(1e-6 * (double)v->integer, 1);
    case 'g':
        return short_number(v->number);
    case 'l':
        return isfinite(v->number) ? seconds(v->number) : (figure){"any"};
    default:
        return fixed(v->number, letter - '0');
    }
}

/* The words of a field with its elements in them, from element `first` on. */
static void print_words(FILE *out, const softsim_server_status *s, const field *f, int first)
{
    int i = first;
    for (const char *at = f->text; *at != '\0'; ++at) {
        if (*at != '@') {
            fputc(*at, out);
            continue;
        }
        const value v = read_field(s, f, i++);
        fputs(format(*++at, &v).text, out);
    }
}

/* The fields of a line, in the list's order. */
static void print_line(FILE *out, const softsim_server_status *s, const char *line)
{
    fprintf(out, "%-11s ", line);
    bool is_first = true;
    for (const field *f = fields; f < fields + FIELD_COUNT; ++f) {
        if (strcmp(f->line, line) != 0) {
            continue;
        }
        fputs(is_first ? "" : ", ", out);
        is_first = false;
        if (f->type == TYPE_text) {
            ss_plain_print(out, "%s", read_field(s, f, 0).text);
        } else {
            print_words(out, s, f, 0);
        }
    }
}

static int64_t sum(const int64_t *values, int count)
{
    uint64_t total = 0; /* wraps on nonsense instead of overflowing */
    for (int i = 0; i < count; ++i) {
        total += (uint64_t)values[i];
    }
    return (int64_t)total;
}

/* What a force is besides its size; "" for an ordinary one. */
static const char *kind_of(int32_t flags)
{
    return (flags & SOFTSIM_FORCE_MODEL_FAULT) != 0 ? ", fault"
           : (flags & SOFTSIM_FORCE_STALE) != 0     ? ", no poses come"
           : (flags & SOFTSIM_FORCE_RAMPING) != 0   ? ", ramping"
           : (flags & SOFTSIM_FORCE_LIMITED) != 0   ? ", limited"
           : (flags & SOFTSIM_FORCE_CONTACT) == 0   ? ", free"
           : (flags & SOFTSIM_FORCE_GRASPING) != 0  ? ", grasping"
                                                    : "";
}

void ss_show_line(FILE *out, const softsim_server_status *s, const ss_show_hand *hand)
{
    fprintf(out, "%s s %s: ", fixed(s->uptime_s, 1).text,
            softsim_verdict_name((softsim_verdict)s->verdict));
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (hand[p].is_here) {
            fprintf(out, "probe %d %s N, pressed in %s mm%s; ", p, fixed(hand[p].force_n, 2).text,
                    fixed(1e3 * hand[p].pressed_m, 1).text, kind_of(hand[p].flags));
        }
    }
    fprintf(out,
            "step %" PRId64 " at %s Hz, p50 %s p99 %s us; late p99 %s us; "
            "poses %" PRId64 " refused %" PRId64 "; forces %" PRId64 " missed %" PRId64
            "; energy %.3g J",
            s->step, fixed(s->simulation_rate_hz, 0).text, fixed(s->step_us[0], 0).text,
            fixed(s->step_us[1], 0).text, fixed(s->lateness_us[1], 0).text, s->poses_received,
            sum(s->poses_refused, SOFTSIM_REFUSED_COUNT), sum(s->probe_forces, SOFTSIM_MAX_PROBES),
            sum(s->probe_missed, SOFTSIM_MAX_PROBES), s->total_j);
    if (s->reason[0] != '\0') {
        ss_plain_print(out, " - %s", s->reason);
    }
    fputc('\n', out);
}

/* What is felt, then a row for each probe that has been served. */
static void show_probes(FILE *out, const softsim_server_status *s, const ss_show_hand *hand)
{
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (hand[p].is_here) {
            fprintf(out, "probe %d     %6s N, pressed in %5s mm%s\n", p,
                    fixed(hand[p].force_n, 2).text, fixed(1e3 * hand[p].pressed_m, 1).text,
                    kind_of(hand[p].flags));
        }
    }
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (s->probe_periods[p] == 0) {
            continue;
        }
        fprintf(out, "probe %d     ", p);
        bool is_first = true;
        for (const field *f = fields; f < fields + FIELD_COUNT; ++f) {
            if (strcmp(f->line, "probe") == 0) {
                fputs(is_first ? "" : ", ", out);
                is_first = false;
                print_words(out, s, f, p);
            }
        }
        fputc('\n', out);
    }
}

void ss_show_page(FILE *out, const softsim_server_status *s, const ss_show_hand *hand)
{
    static const char *const lines[] = {
        "scene",    "model",      "verdict", "up",     "body", "simulation", "step time",
        "lateness", "loop delay", "energy",  "device", "wire", "poses"};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; ++i) {
        print_line(out, s, lines[i]);
        if (strcmp(lines[i], "verdict") == 0) {
            ss_plain_print(out, "%s%s%s", softsim_verdict_name((softsim_verdict)s->verdict),
                           s->reason[0] != '\0' ? ": " : "", s->reason);
        } else if (strcmp(lines[i], "poses") == 0) {
            for (int reason = 0; reason < SOFTSIM_REFUSED_COUNT; ++reason) {
                if (s->poses_refused[reason] != 0) {
                    fprintf(out, ", %" PRId64 " refused (%s)", s->poses_refused[reason],
                            softsim_refusal_name((softsim_refusal)reason));
                }
            }
        }
        fputc('\n', out);
    }
    fputc('\n', out);
    show_probes(out, s, hand);
}
