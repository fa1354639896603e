/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The scene as text: every value that was chosen says why. */
#include "organ.h"

#include <math.h>
#include <string.h>

#include "rt/plain.h"

void organ_write_model(FILE *out, const organ *o)
{
    const ss_hints_body body = {.youngs_modulus = o->tissue->youngs_modulus,
                                .poisson_ratio = tissue_poisson_ratio,
                                .density = o->tissue->density,
                                .size = o->diagonal,
                                .thickness =
                                    o->is_closed ? o->volume / o->area : 0.02 * o->diagonal,
                                .is_closed = o->is_closed};
    const ss_model_hints *hints = o->model->hints;
    ss_hints_setting setting = {.body = &body,
                                .material = hints != NULL ? hints->material[2] : NULL,
                                .scale = o->scale,
                                .damping = tissue_damping};
    if (hints != NULL && hints->write_organ != NULL) {
        hints->write_organ(out, o->model, &setting);
    } else {
        ss_hints_write_solid(out, o->model, &setting);
    }
}

bool organ_is_text(const char *text)
{
    size_t length = 0;
    for (size_t left = strlen(text); left > 0; text += length, left -= length) {
        length = ss_plain_length(text, left);
        if (length == 0 || !ss_plain_is_shown(text, length)) {
            return false;
        }
    }
    return true;
}

void organ_write_quoted(FILE *out, const char *text)
{
    (void)fputc('"', out);
    for (const unsigned char *c = (const unsigned char *)text; *c != '\0'; ++c) {
        if (*c < 0x20 || *c == 0x7f) {
            (void)fprintf(out, "\\x%02x", *c);
        } else {
            (void)fprintf(out, *c == '"' || *c == '\\' ? "\\%c" : "%c", *c);
        }
    }
    (void)fputc('"', out);
}

static void write_head(FILE *out, const organ *o)
{
    const trial_result *t = &o->trial;
    const double hertz =
        trial_hertz(o->tissue->youngs_modulus, tissue_poisson_ratio, o->radius, t->held.depth);
    (void)fprintf(out,
                  "# Written by softsim-mesh scene: %s as %s, %.3g x %.3g x %.3g mm, %d nodes.\n",
                  o->tissue->name, o->model->name, 1e3 * (o->high[0] - o->low[0]),
                  1e3 * (o->high[1] - o->low[1]), 1e3 * (o->high[2] - o->low[2]), o->node_count);
    (void)fprintf(out,
                  "# To feel it: softsimd THIS.yaml, and when that is ready, in another terminal\n"
                  "#   softsim-bridge --device sim --duration 8");
    if (strcmp(o->axes, "x,y,z") != 0) {
        (void)fprintf(out, " --axes %s", o->axes);
    }
    if (o->hand_scale < 1.0) {
        (void)fprintf(out, " --scale %.3g", o->hand_scale);
    }
    (void)fprintf(out,
                  "\n# which finds the tissue from %s by itself; pressed below: at --offset-m "
                  "%.4f,%.4f,%.4f\n",
                  o->side, o->touch.origin[0], o->touch.origin[1], o->touch.origin[2]);
    (void)fprintf(
        out,
        "# Pressed as this was written, and held: %.3g N at %.3g mm of indentation (Hertz: %.3g N "
        "for the %.3g mm\n# that the surface went), then %.3g N at %.3g mm: %s%s%s.\n"
        "# Beside softsim-bridge's peak force: these are at rest; in motion, at %.3g mm/s, the "
        "first was %.3g N.\n",
        t->held.force, 1e3 * t->held.indentation, hertz, 1e3 * t->held.depth, t->deepest.force,
        1e3 * t->deepest.indentation, softsim_verdict_name(t->verdict),
        t->reason[0] != '\0' ? ": " : "", t->reason, 1e3 * t->speed, t->moving_force);
    (void)fprintf(out, "# A step of %.3g ms is planned with %.3g ms of a core", 1e3 * o->step_s,
                  1e-3 * o->step_cost_us);
    if (o->stable_step_s > 0.0 && isfinite(o->stable_step_s)) {
        (void)fprintf(out, "; sub-steps of up to %.3g ms are stable", 1e3 * o->stable_step_s);
    }
    (void)fprintf(out, ".\n");
}

static void write_object(FILE *out, const organ *o, bool is_draft)
{
    (void)fprintf(out, "object:\n  mesh: ");
    organ_write_quoted(out, o->mesh_name);
    (void)fprintf(out, "\n  units: %s  # %s\n", o->unit, o->unit_words);
    if (o->is_repaired) {
        (void)fprintf(out, "  repair: true\n");
    }
    (void)fprintf(
        out,
        "  fixed:  # what does not move; in metres: plane (what lies behind it), box_m, sphere, "
        "group, nodes\n    - %s",
        o->fixed);
    if (!is_draft) {
        (void)fprintf(out, "  # %d of %d nodes", o->fixed_count, o->node_count);
    }
    (void)fprintf(out, "\n");
}

void organ_write(FILE *out, const organ *o, bool is_draft)
{
    const bool is_physical = o->model->hints == NULL || o->model->hints->write_organ == NULL;
    if (!is_draft) {
        write_head(out, o);
    }
    (void)fprintf(out, "softsim: 1\n");
    write_object(out, o, is_draft);
    (void)fprintf(out, "model:\n  name: %s\n", o->model->name);
    (void)fprintf(out, "  # E %.4g Pa: %s%s\n", o->tissue->youngs_modulus,
                  o->tissue->modulus_source,
                  is_physical ? "" : "; these constants press as that does, at the depth above");
    organ_write_model(out, o);
    (void)fprintf(
        out,
        "contact:\n  tools:\n    - {probe: 0, shape: {sphere: {radius_mm: %.3g}}}  # the mesh's "
        "edges are %.3g mm long\n",
        1e3 * o->radius, 1e3 * o->edge);
    (void)fprintf(out, "  working_force_n: %.3g\n", o->working_force);
    (void)fprintf(out, "haptic: {max_force_n: %.3g}\n", o->max_force);
}
