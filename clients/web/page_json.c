/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "page_json.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/plain.h"
#include "status_json.h"

int64_t ss_session_of(const softsim_server_status *status)
{
    const double uptime_us = 1e6 * status->uptime_s;
    return fabs(uptime_us) < 1e18 && llabs(status->utime) < INT64_C(1000000000000000000)
               ? status->utime - llround(uptime_us)
               : 0;
}

/* JSON as `put` writes it; NULL when out of memory. */
static char *json_of(void (*put)(FILE *out, const void *what), const void *what)
{
    char *json = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&json, &size);
    if (out == NULL) {
        return NULL;
    }
    put(out, what);
    fclose(out);
    return json;
}

static void put_status(FILE *out, const void *what)
{
    const softsim_server_status *status = what;
    fputs("{\"type\": \"status\", \"status\": ", out);
    ss_status_json(out, status);
    fprintf(out, ", \"paused\": %s, \"session\": %" PRId64 "}",
            (status->fault_bits & SOFTSIM_STATUS_PAUSED) != 0 ? "true" : "false",
            ss_session_of(status));
}

char *ss_json_of_status(const softsim_server_status *status)
{
    return json_of(put_status, status);
}

/* ---- scenes ---- */

static void put_tool(FILE *out, const softsim_scene_report *scene, int32_t p, const float *hull)
{
    static const char *const name[] = {
#define X(form, value, text) [value] = (text),
        SOFTSIM_TOOL_LIST(X)
#undef X
    };
    fprintf(out, "{\"probe\": %d, \"form\": \"%s\", \"size\": [%.9g, %.9g, %.9g], \"hull\": [", p,
            name[scene->form[p]], scene->size[p][0], scene->size[p][1], scene->size[p][2]);
    for (int32_t i = 0; i < 3 * scene->hull_count[p]; ++i) {
        fprintf(out, "%s%.7g", i > 0 ? ", " : "", (double)hull[i]);
    }
    fputs("]}", out);
}

/* "PATH=VALUE LOW HIGH UNIT"; what has another form is left out. */
static bool put_parameter(FILE *out, const char *text, bool is_first)
{
    char path[128], value[64], unit[96] = "";
    double low = 0.0, high = 0.0;
    if (sscanf(text, "%127[^= ]=%63s %lf %lf %95[^\n]", path, value, &low, &high, unit) < 4 ||
        !isfinite(low) || !isfinite(high)) {
        return false;
    }
    fputs(is_first ? "{\"path\": " : ", {\"path\": ", out);
    ss_plain_json(out, path);
    fputs(", \"value\": ", out);
    ss_plain_json(out, value);
    fprintf(out, ", \"low\": %.9g, \"high\": %.9g, \"unit\": ", low, high);
    ss_plain_json(out, unit);
    fputs("}", out);
    return true;
}

typedef struct scene_of {
    const softsim_scene_report *scene;
    int64_t session;
} scene_of;

static void put_scene(FILE *out, const void *what)
{
    const softsim_scene_report *scene = ((const scene_of *)what)->scene;
    const struct {
        const char *key, *text;
    } texts[] = {{"name", scene->name}, {"model", scene->model}, {"field", scene->field}};
    fprintf(out, "{\"type\": \"scene\"");
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        fprintf(out, ", \"%s\": ", texts[i].key);
        ss_plain_json(out, texts[i].text);
    }
    fputs(", \"tools\": [", out);
    const float *hull = scene->hull;
    const char *comma = "";
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (scene->form[p] != SOFTSIM_TOOL_NONE) {
            fputs(comma, out);
            put_tool(out, scene, p, hull);
            comma = ", ";
        }
        hull += 3 * (size_t)scene->hull_count[p];
    }
    fputs("], \"parameters\": [", out);
    bool is_first = true;
    for (int32_t i = 0; i < scene->parameter_count; ++i) {
        is_first = !put_parameter(out, scene->parameter[i], is_first) && is_first;
    }
    fprintf(out, "], \"session\": %" PRId64 "}", ((const scene_of *)what)->session);
}

char *ss_json_of_scene(const softsim_scene_report *scene, int64_t session)
{
    return json_of(put_scene, &(scene_of){scene, session});
}
