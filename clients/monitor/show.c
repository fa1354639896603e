/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "show.h"

#include <inttypes.h>
#include <math.h>

#include "rt/plain.h"
#include "softsim/types.h"

/* ---- JSON ---- */

static void json_text(FILE *out, const char *name, const char *text)
{
    fprintf(out, ", \"%s\": \"", name);
    for (const unsigned char *at = (const unsigned char *)text; *at != '\0'; ++at) {
        if (*at == '"' || *at == '\\') {
            fprintf(out, "\\%c", *at);
        } else if (*at < 0x20 || *at >= 0x7F) {
            fprintf(out, "\\u%04x", *at); /* bytes beyond ASCII are read as Latin-1 */
        } else {
            fputc(*at, out);
        }
    }
    fputc('"', out);
}

static void json_integer(FILE *out, const char *name, int64_t value)
{
    fprintf(out, ", \"%s\": %" PRId64, name, value);
}

static void json_integers(FILE *out, const char *name, const int64_t *value, int count)
{
    fprintf(out, ", \"%s\": ", name);
    for (int i = 0; i < count; ++i) {
        fprintf(out, "%s%" PRId64, i == 0 ? "[" : ", ", value[i]);
    }
    fputc(']', out);
}

static void json_value(FILE *out, double value)
{
    if (isfinite(value)) {
        fprintf(out, "%.17g", value);
    } else {
        fputs("null", out);
    }
}

static void json_number(FILE *out, const char *name, double value)
{
    fprintf(out, ", \"%s\": ", name);
    json_value(out, value);
}

static void json_numbers(FILE *out, const char *name, const double *value, int count)
{
    fprintf(out, ", \"%s\": ", name);
    for (int i = 0; i < count; ++i) {
        fputs(i == 0 ? "[" : ", ", out);
        json_value(out, value[i]);
    }
    fputc(']', out);
}

void ss_show_json(FILE *out, const softsim_server_status_t *s)
{
#define INTEGER(field)         json_integer(out, #field, s->field)
#define INTEGERS(field, count) json_integers(out, #field, s->field, count)
#define NUMBER(field)          json_number(out, #field, s->field)
#define NUMBERS(field, count)  json_numbers(out, #field, s->field, count)
#define TEXT(field)            json_text(out, #field, s->field)
    fprintf(out, "{\"utime\": %" PRId64, s->utime);
    INTEGER(seq);
    INTEGER(verdict);
    INTEGER(fault_bits);
    INTEGER(threads);
    INTEGER(nodes);
    INTEGER(active_nodes);
    INTEGER(elements);
    INTEGER(worst_element);
    INTEGER(substeps);
    INTEGER(probes);
    INTEGER(plan_hash);
    INTEGER(state_hash);
    INTEGER(step);
    INTEGER(bytes_in_use);
    INTEGER(poses_received);
    INTEGER(poses_superseded);
    INTEGERS(poses_refused, 8);
    INTEGER(mesh_bytes_sent);
    INTEGER(wire_dropped);
    INTEGERS(probe_periods, 8);
    INTEGERS(probe_forces, 8);
    INTEGERS(probe_missed, 8);
    NUMBER(uptime_s);
    NUMBER(simulation_rate_hz);
    NUMBER(stable_step_s);
    NUMBERS(step_us, 3);
    NUMBERS(lateness_us, 4);
    NUMBER(kinetic_j);
    NUMBER(elastic_j);
    NUMBER(total_j);
    NUMBER(energy_to_device_j);
    NUMBER(energy_from_device_j);
    NUMBERS(worst_contact_j, 8);
    NUMBERS(loop_delay_ms, 2);
    NUMBERS(stiffness_limit_n_per_m, 8);
    INTEGER(stiffness_backoffs);
    TEXT(scene);
    TEXT(model);
    TEXT(reason);
    fputs("}\n", out);
#undef INTEGER
#undef INTEGERS
#undef NUMBER
#undef NUMBERS
#undef TEXT
}

/* ---- for people ---- */

/* A figure of a message: whatever a stranger says, no longer than a column. */
typedef struct figure {
    char text[32];
} figure;

static figure fixed(double value, int decimals)
{
    figure f;
    (void)snprintf(f.text, sizeof f.text, fabs(value) < 1e12 ? "%.*f" : "%.*g", decimals, value);
    return f;
}

static int64_t sum(const int64_t *value, int count)
{
    uint64_t total = 0; /* wraps on nonsense instead of overflowing */
    for (int i = 0; i < count; ++i) {
        total += (uint64_t)value[i];
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

void ss_show_line(FILE *out, const softsim_server_status_t *s, const ss_show_hand *hand)
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
            sum(s->poses_refused, 8), sum(s->probe_forces, 8), sum(s->probe_missed, 8), s->total_j);
    if (s->reason[0] != '\0') {
        ss_plain_print(out, " - %s", s->reason);
    }
    fputc('\n', out);
}

static void show_probes(FILE *out, const softsim_server_status_t *s, const ss_show_hand *hand)
{
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (hand[p].is_here) {
            fprintf(out, "probe %d     %6s N, pressed in %5s mm%s\n", p,
                    fixed(hand[p].force_n, 2).text, fixed(1e3 * hand[p].pressed_m, 1).text,
                    kind_of(hand[p].flags));
        }
    }
    fputs("probe    periods     forces     missed   worst contact   stiffness limit\n", out);
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (s->probe_periods[p] != 0) {
            fprintf(out, "%5d %10" PRId64 " %10" PRId64 " %10" PRId64 " %13.3g J %13s N/m\n", p,
                    s->probe_periods[p], s->probe_forces[p], s->probe_missed[p],
                    s->worst_contact_j[p], fixed(s->stiffness_limit_n_per_m[p], 0).text);
        }
    }
}

void ss_show_page(FILE *out, const softsim_server_status_t *s, const ss_show_hand *hand)
{
    char limit[32] = "any", worst[16] = "none";
    if (isfinite(s->stable_step_s)) {
        (void)snprintf(limit, sizeof limit, "%.3g s", s->stable_step_s);
    }
    if (s->worst_element >= 0) {
        (void)snprintf(worst, sizeof worst, "%d", s->worst_element);
    }
    ss_plain_print(out, "scene       %s\n", s->scene);
    ss_plain_print(out, "model       %s\n", s->model);
    ss_plain_print(out, "verdict     %s%s%s\n", softsim_verdict_name((softsim_verdict)s->verdict),
                   s->reason[0] != '\0' ? ": " : "", s->reason);
    fprintf(out,
            "up          %s s, %d threads, %.1f MB\n"
            "body        %d nodes (%d active), %d elements, worst element %s\n"
            "simulation  step %" PRId64 " at %s Hz, %d substeps, stable step %s\n"
            "step time   p50 %s  p99 %s  max %s us\n"
            "lateness    p50 %s  p99 %s  p99.9 %s  max %s us\n"
            "loop delay  p50 %s  p95 %s ms\n"
            "energy      kinetic %.3g  elastic %.3g  total %.3g J\n"
            "device      given %.3g  taken %.3g J, %" PRId64 " stiffness back-offs\n"
            "wire        %.1f MB of mesh sent, %" PRId64 " messages dropped\n"
            "poses       %" PRId64 " received, %" PRId64 " superseded",
            fixed(s->uptime_s, 1).text, s->threads, 1e-6 * (double)s->bytes_in_use, s->nodes,
            s->active_nodes, s->elements, worst, s->step, fixed(s->simulation_rate_hz, 1).text,
            s->substeps, limit, fixed(s->step_us[0], 0).text, fixed(s->step_us[1], 0).text,
            fixed(s->step_us[2], 0).text, fixed(s->lateness_us[0], 0).text,
            fixed(s->lateness_us[1], 0).text, fixed(s->lateness_us[2], 0).text,
            fixed(s->lateness_us[3], 0).text, fixed(s->loop_delay_ms[0], 2).text,
            fixed(s->loop_delay_ms[1], 2).text, s->kinetic_j, s->elastic_j, s->total_j,
            s->energy_to_device_j, s->energy_from_device_j, s->stiffness_backoffs,
            1e-6 * (double)s->mesh_bytes_sent, s->wire_dropped, s->poses_received,
            s->poses_superseded);
    for (int i = 0; i < SOFTSIM_REFUSED_COUNT; ++i) {
        if (s->poses_refused[i] != 0) {
            fprintf(out, ", %" PRId64 " refused (%s)", s->poses_refused[i],
                    softsim_refusal_name(i));
        }
    }
    fputs("\n\n", out);
    show_probes(out, s, hand);
}
