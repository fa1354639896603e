/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "status_json.h"

#include <inttypes.h>
#include <math.h>

#include "rt/plain.h"

static void put_int32_t(FILE *out, int32_t value)
{
    fprintf(out, "%" PRId32, value);
}

static void put_int64_t(FILE *out, int64_t value)
{
    fprintf(out, "%" PRId64, value);
}

static void put_double(FILE *out, double value)
{
    if (isfinite(value)) {
        fprintf(out, "%.17g", value);
    } else {
        fputs("null", out);
    }
}

void ss_status_json(FILE *out, const softsim_server_status *status)
{
    const char *before = "{";
#define NAME(name)                                                                                 \
    fprintf(out, "%s\"" #name "\": ", before);                                                     \
    before = ", ";
#define SCALAR(type, name, line, text) NAME(name) put_##type(out, status->name);
#define ARRAY(type, name, count, line, text)                                                       \
    NAME(name)                                                                                     \
    for (int i = 0; i < (count); ++i) {                                                            \
        fputs(i > 0 ? ", " : "[", out);                                                            \
        put_##type(out, status->name[i]);                                                          \
    }                                                                                              \
    fputs("]", out);
#define TEXT(name, line) NAME(name) ss_plain_json(out, status->name);
    SOFTSIM_SERVER_STATUS_LIST(SCALAR, ARRAY, TEXT)
#undef NAME
#undef SCALAR
#undef ARRAY
#undef TEXT
    fputs("}", out);
}
