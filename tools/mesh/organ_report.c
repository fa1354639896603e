/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What softsim-mesh scene says of the scene it wrote, and what to do next. Where the press is not
 * good, or its mesh is coarse or slow, a surface of even edges comes next: edges as long as the
 * tool's radius are what a press needs, and no more of them are paid for.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "organ.h"
#include "rt/plain.h"

static const double SOFT = 0.5, HARD = 1.6; /* times Hertz's: told beyond */
static const double UNEVEN = 0.8;           /* of the edges that a press needs */

double organ_round(double x)
{
    const double unit = pow(10.0, floor(log10(x)) - 1.0);
    return unit * round(x / unit);
}

double organ_ratio(const organ *o)
{
    const double hertz = trial_hertz(o->tissue->youngs_modulus, tissue_poisson_ratio, o->radius,
                                     o->trial.held.depth);
    return hertz > 0.0 ? o->trial.held.force / hertz : 0.0;
}

/* Of inner tetrahedra, of e^3 / 8.5 each: 1500 of second order are felt at 1 kHz. */
static double filling_edge_mm(const organ *o)
{
    return organ_round(1e3 * cbrt(8.5 * o->volume / 1500.0));
}

static bool is_coarse(const organ *o)
{
    return o->edge > o->radius;
}

static bool is_slow(const organ *o)
{
    return o->step_cost_us > 0.5e6 * o->step_s || o->trial.step_us > o->trial.period_us;
}

/* Edges for the tool that was asked for, or for the one that the body's size asks for. */
static double even_edge(const organ_request *q, const organ *o)
{
    return (q->tool_mm > 0.0 ? o->radius : o->usual_radius) / ORGAN_RADIUS_PER_EDGE;
}

/* Would remeshing help? Of what crosses itself, and of volumes, it is for another program. */
static bool helps_to_even(const organ_request *q, const organ *o)
{
    return !o->has_volume && o->crossing_count == 0 &&
           (is_coarse(o) || (is_slow(o) && o->edge < UNEVEN * even_edge(q, o)));
}

/* The commands that come before a scene of an even surface, ending with its name. */
static void write_evening(FILE *out, const organ_request *q, const organ *o)
{
    if (o->is_repaired) {
        ss_plain_print(out, "softsim-mesh convert --repair %s MENDED.obj; ", q->mesh);
    }
    ss_plain_print(out, "softsim-mesh remesh %s EVEN.obj --units %s --edge-mm %.2g",
                   o->is_repaired ? "MENDED.obj" : q->mesh, o->unit, 1e3 * even_edge(q, o));
}

/* ---- before a scene is written ---- */

softsim_status organ_refuse_surface(const organ_request *q, const organ *o, softsim_error *error)
{
    const char *option = q->model != NULL ? "--model:" : "--for:";
    const char *value = q->model != NULL ? q->model : "accuracy";
    if (o->crossing_count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s %s needs tetrahedra, and %s is a surface whose triangles cross each "
                          "other, so that it cannot be filled: move them apart (softsim-mesh check "
                          "says which); or --for feel --model cnn-energy",
                          option, value, q->mesh);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    char mending[512] = "";
    if (o->is_repaired) {
        (void)snprintf(mending, sizeof mending, "softsim-mesh convert --repair %.400s MENDED.obj, ",
                       q->mesh);
    }
    softsim_error_add(
        error, SOFTSIM_ERROR_ARGUMENT,
        "%s %s needs tetrahedra, and %s is a surface%s: %ssoftsim-mesh tetrahedralize %s "
        "VOLUME.msh --units %s --edge-mm %.3g, then softsim-mesh scene VOLUME.msh ...; or --for "
        "feel --model cnn-energy",
        option, value, q->mesh, o->is_closed ? "" : " with holes, which are to be closed first",
        mending, o->is_repaired ? "MENDED.obj" : q->mesh, o->unit, filling_edge_mm(o));
    return SOFTSIM_ERROR_ARGUMENT;
}

void organ_advise(const organ_request *q, const organ *o, softsim_error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *stream = helps_to_even(q, o) ? open_memstream(&text, &size) : NULL;
    if (stream != NULL) {
        write_evening(stream, q, o);
        if (fclose(stream) == 0) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "%s: its edges, %.3g mm, are long for a hand's tool: %s, then a "
                              "scene of EVEN.obj",
                              q->mesh, 1e3 * o->edge, text);
        }
    }
    free(text);
    if (o->part_count > 1) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: it has %d separate parts, and each is to be held: join them, leave "
                          "out what is not to be felt, or give --fixed an entry that reaches all",
                          q->mesh, o->part_count);
    }
}

/* ---- of a scene that was written ---- */

static void warn_of_mesh(const organ_request *q, const organ *o)
{
    if (o->unit_doubt[0] != '\0') {
        ss_plain_print(stderr, "softsim-mesh: warning: %s: %s\n", q->out, o->unit_doubt);
    }
    if (o->crossing_count > 0) {
        ss_plain_print(stderr,
                       "softsim-mesh: warning: %s: %lld triangles of %s cross others: the body "
                       "goes through itself there; softsim-mesh check says where\n",
                       q->out, (long long)o->crossing_count, q->mesh);
    } else if (!o->is_crossing_complete) {
        ss_plain_print(stderr,
                       "softsim-mesh: warning: %s: too many triangles of %s lie about each other "
                       "to look at every pair: there may be some that cross\n",
                       q->out, q->mesh);
    }
    if (o->part_count > 1) {
        ss_plain_print(stderr,
                       "softsim-mesh: warning: %s: %s has %d separate parts: forces do not pass "
                       "between them; join them if they should be one\n",
                       q->out, q->mesh, o->part_count);
    }
    if (!o->is_closed && !o->has_volume) {
        ss_plain_print(stderr,
                       "softsim-mesh: warning: %s: %s has holes (%lld open edges): it is felt as a "
                       "sheet, without a volume; close them if the body should have one: "
                       "softsim-mesh convert --repair fills small ones\n",
                       q->out, q->mesh, (long long)o->open_edges);
    }
}

static void warn_of_force(const organ_request *q, const organ *o)
{
    const double ratio = organ_ratio(o);
    if (is_coarse(o)) {
        ss_plain_print(
            stderr,
            "softsim-mesh: warning: %s: the mesh is coarse for the tool: edges of %.3g mm, a "
            "ball of %.3g mm: forces may come out wrong (here %.2f times Hertz's); take a finer "
            "mesh, or a larger --tool-mm\n",
            q->out, 1e3 * o->edge, 1e3 * o->radius, ratio);
    } else if (o->trial.has_touched && ratio < SOFT) {
        ss_plain_print(
            stderr,
            "softsim-mesh: warning: %s: the force is %.2f times Hertz's of a large, flat body: "
            "what is pressed gives way as a whole, or is thin beside the tool; %d of %d nodes are "
            "held: hold more of it with --fixed (--preview draws what is held)\n",
            q->out, ratio, o->fixed_count, o->node_count);
    } else if (o->trial.has_touched && ratio > HARD) {
        ss_plain_print(
            stderr,
            "softsim-mesh: warning: %s: the force is %.2f times Hertz's of a large, flat body: it "
            "is held close to the tool, or the mesh is coarse: take a finer mesh, or hold less of "
            "it with --fixed\n",
            q->out, ratio);
    }
}

static void warn_of_press(const organ_request *q, const organ *o)
{
    const trial_result *t = &o->trial;
    if (t->verdict != SOFTSIM_VERDICT_GOOD) {
        ss_plain_print(stderr,
                       "softsim-mesh: warning: %s: the press is %s: %s; try another --model, "
                       "or a mesh of another size\n",
                       q->out, softsim_verdict_name(t->verdict), t->reason);
    }
    if (is_slow(o)) {
        ss_plain_print(
            stderr,
            "softsim-mesh: warning: %s: slower than real time, or hardly faster: a step of %.3g ms "
            "is planned with %.3g ms of a core and took %.3g ms: a server makes longer steps of "
            "it, or falls behind, and forces come out higher than here; take a coarser or more "
            "even mesh, or --for speed\n",
            q->out, 1e3 * o->step_s, 1e-3 * o->step_cost_us, 1e-3 * t->step_us);
    }
}

static void tell_press(const organ *o)
{
    const trial_result *t = &o->trial;
    (void)printf("  pressed and held: %.3g N at %.3g mm of indentation, %.2f times Hertz's force "
                 "for %.4g Pa and the %.3g mm that the surface went; %.3g N at %.3g mm: %s%s%s\n",
                 t->held.force, 1e3 * t->held.indentation, organ_ratio(o),
                 o->tissue->youngs_modulus, 1e3 * t->held.depth, t->deepest.force,
                 1e3 * t->deepest.indentation, softsim_verdict_name(t->verdict),
                 t->reason[0] != '\0' ? ": " : "", t->reason);
    (void)printf("  beside softsim-bridge's peak force: these are at rest; in motion, at %.3g "
                 "mm/s, the first was %.3g N\n",
                 1e3 * t->speed, t->moving_force);
    (void)printf("  a step of %.3g ms took %.3g ms of a core here (planned: %.3g ms)%s\n",
                 1e3 * o->step_s, 1e-3 * t->step_us, 1e-3 * o->step_cost_us,
                 is_slow(o) ? ": not in real time, or hardly" : "");
}

static void tell_filling(const organ_request *q, const organ *o)
{
    ss_plain_print(stdout, "  for models with physical constants, fill it: ");
    if (o->is_repaired) {
        ss_plain_print(stdout, "softsim-mesh convert --repair %s MENDED.obj, then ", q->mesh);
    }
    ss_plain_print(stdout, "softsim-mesh tetrahedralize %s VOLUME.msh --units %s --edge-mm %.3g\n",
                   o->is_repaired ? "MENDED.obj" : q->mesh, o->unit, filling_edge_mm(o));
}

static void tell_next(const organ_request *q, const organ *o)
{
    if (helps_to_even(q, o)) {
        ss_plain_print(stdout, "next: a mesh that suits the tool: ");
        write_evening(stdout, q, o);
        ss_plain_print(stdout, "; softsim-mesh scene EVEN.obj --tissue %s --units %s --out %s\n",
                       q->tissue_name, o->unit, q->out);
    }
    ss_plain_print(stdout,
                   "%s: softsimd %s, and in another terminal softsim-bridge --device sim "
                   "--duration 8",
                   helps_to_even(q, o) ? "as it is" : "next", q->out);
    if (strcmp(o->axes, "x,y,z") != 0) {
        (void)printf(" --axes %s", o->axes);
    }
    if (o->hand_scale < 1.0) {
        (void)printf(" --scale %.3g", o->hand_scale);
    }
    (void)printf("\n");
}

void organ_report(const organ_request *q, const organ *o)
{
    warn_of_mesh(q, o);
    warn_of_press(q, o);
    warn_of_force(q, o);
    ss_plain_print(stdout, "%s: %s, %d nodes%s, in %s (%s)\n", q->out, o->model->name,
                   o->node_count, o->has_volume ? "" : " of a surface", o->unit, o->unit_words);
    if (o->is_repaired) {
        ss_plain_print(stdout,
                       "  mended as it is read (object.repair); softsim-mesh check says what\n");
    }
    (void)printf("  held: %d nodes; a ball of %.3g mm touches at %.4f,%.4f,%.4f, coming from %s\n",
                 o->fixed_count, 1e3 * o->radius, o->touch.origin[0], o->touch.origin[1],
                 o->touch.origin[2], o->side);
    tell_press(o);
    if (q->model == NULL && o->passed_over[0] != '\0') {
        ss_plain_print(stdout, "  passed over: %s\n", o->passed_over);
    }
    if (!o->has_volume && o->is_closed && o->crossing_count == 0 && q->purpose != FOR_SPEED &&
        q->model == NULL) {
        tell_filling(q, o);
    }
    tell_next(q, o);
}
