/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The unit of a mesh by its size: files do not say it, and an organ has 2 to 30 cm. */
#include "organ.h"

#include <math.h>

#include "command.h"
#include "rt/vec.h"

static const double ORGAN_LOW_M = 0.02, ORGAN_HIGH_M = 0.30, ORGAN_USUAL_M = 0.12;
static const double LEAST_MM = 2.0, GREATEST_MM = 2e4; /* for tools and models, of --units */

static bool is_organ(double size)
{
    return size >= ORGAN_LOW_M * 0.999 && size <= ORGAN_HIGH_M * 1.001;
}

/* The unit in which the longest side is nearest to an organ's. -1: in none of them. *out_other:
 * another that would do, or -1. */
static int32_t judge(double longest, int32_t *out_other)
{
    int32_t best = -1;
    double least = INFINITY;
    *out_other = -1;
    for (int32_t u = 0; u < UNIT_COUNT; ++u) {
        const double size = longest * metres_per_unit(u);
        const double off = fabs(log(size / ORGAN_USUAL_M));
        if (is_organ(size)) {
            *out_other = off < least ? best : u;
            best = off < least ? u : best;
            least = fmin(least, off);
        }
    }
    return best;
}

/* What was given is taken; that no organ has this size is said, with what would be one. */
static void doubt(organ *o, double longest, int32_t given, int32_t judged)
{
    char would[80] = "; it would have none in mm, cm, dm or m";
    if (judged >= 0) {
        (void)snprintf(would, sizeof would, "; in %s it has %.4g mm: --units %s", unit_name(judged),
                       1e3 * longest * metres_per_unit(judged), unit_name(judged));
    }
    (void)snprintf(
        o->unit_doubt, sizeof o->unit_doubt,
        "--units %s makes the mesh's longest side %.4g mm, and an organ has 2 to 30 cm%s",
        unit_name(given), 1e3 * longest * metres_per_unit(given), would);
}

softsim_status organ_choose_unit(organ *o, const char *path, int32_t given, ss_mesh *mesh,
                                 softsim_error *error)
{
    static const double still[3] = {0.0, 0.0, 0.0};
    double low[3], high[3], longest = 0.0;
    ss_bounds3(mesh->node_count, (const double(*)[3])mesh->position, low, high);
    for (int k = 0; k < 3; ++k) {
        longest = fmax(longest, high[k] - low[k]);
    }
    int32_t other = -1;
    const int32_t judged = judge(longest, &other);
    const int32_t unit = given >= 0 ? given : judged;
    if (unit < 0) {
        softsim_error_add(
            error, SOFTSIM_ERROR_ARGUMENT,
            "%s: %.3g x %.3g x %.3g is the size of an organ (2 to 30 cm) in none of mm, "
            "cm, dm, m; give --units",
            path, high[0] - low[0], high[1] - low[1], high[2] - low[2]);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    const double size_mm = 1e3 * longest * metres_per_unit(unit);
    if (size_mm < LEAST_MM || size_mm > GREATEST_MM) {
        softsim_error_add(
            error, SOFTSIM_ERROR_ARGUMENT,
            "--units: in %s its longest side has %.4g mm, and a tissue's scene has %g to %g: give "
            "another, or leave it out",
            unit_name(unit), size_mm, LEAST_MM, GREATEST_MM);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    if (given < 0) {
        (void)snprintf(
            o->unit_words, sizeof o->unit_words,
            "judged by size, %.3g x %.3g x %.3g: an organ has 2 to 30 cm, so %.4g mm%s%s%s",
            high[0] - low[0], high[1] - low[1], high[2] - low[2], size_mm, other >= 0 ? "; " : "",
            other >= 0 ? unit_name(other) : "", other >= 0 ? " would do too: --units" : "");
    } else {
        (void)snprintf(o->unit_words, sizeof o->unit_words, "as given: the longest side is %.4g mm",
                       size_mm);
    }
    if (given >= 0 && !is_organ(1e-3 * size_mm)) {
        doubt(o, longest, given, judged);
    }
    if (given < 0 && other >= 0) {
        (void)snprintf(o->unit_doubt, sizeof o->unit_doubt,
                       "the mesh's unit was judged: in %s its longest side is %.4g mm; %s would do "
                       "too, with %.4g mm: say which with --units",
                       unit_name(unit), size_mm, unit_name(other),
                       1e3 * longest * metres_per_unit(other));
    }
    o->unit = unit_name(unit);
    ss_mesh_transform(mesh, metres_per_unit(unit), still, still);
    return SOFTSIM_OK;
}
