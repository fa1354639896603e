/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What softsim-mesh scene says of the scene it wrote, and what to do next. Where the press is not
 * good, or its mesh is coarse or slow, a surface of even edges comes next: edges as long as the
 * tool's radius are what a press needs, and no more of them are paid for.
 */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "organ.h"
#include "rt/plain.h"

static const double SOFT = 0.5, HARD = 1.6; /* times Hertz's: told beyond */
static const double STIFF = 1.3;            /* of linear tetrahedra, which only err so */
static const double NEARLY = 0.8;           /* of a step's time: hardly faster than real time */
static const double UNEVEN = 0.8;           /* of the edges that a press needs */
static const double MOST_TRIANGLES = 2e4;   /* more are not felt in time by any model */

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

/* Edges that a thin body keeps its shape with: V / A is half a plate's thickness, a quarter of a
 * rod's and a sixth of a ball's. */
static double longest_edge(const organ *o)
{
    return o->is_closed && o->area > 0.0 ? 1.5 * o->volume / o->area : INFINITY;
}

/* Of tetrahedra, of e^3 / 8.5 each: 1000 of second order are felt at 1 kHz. */
static double filling_edge_mm(const organ *o)
{
    return organ_round(1e3 * fmin(cbrt(8.5 * o->volume / 1000.0), longest_edge(o)));
}

static bool is_coarse(const organ *o)
{
    return o->edge > o->radius;
}

static bool is_slow(const organ *o)
{
    return o->step_cost_us > 0.5e6 * o->step_s || o->trial.step_us > NEARLY * o->trial.period_us;
}

/* Edges for the tool that was asked for, or for the one that the body's size asks for. */
static double even_edge(const organ_request *q, const organ *o)
{
    const double radius = q->tool_mm > 0.0 ? o->radius : o->usual_radius;
    return fmin(radius / ORGAN_RADIUS_PER_EDGE, longest_edge(o));
}

bool organ_is_stiff(const organ *o)
{
    return o->model->needs_volume && !o->model->takes_second_order && o->trial.has_touched &&
           organ_ratio(o) > STIFF;
}

/* Can a mesh of even edges be made that is felt in time? What crosses itself is for another
 * program; what fills a surface of short edges is too much for the models that are right on it. */
static bool can_be_even(const organ_request *q, const organ *o)
{
    const double edge = even_edge(q, o);
    return o->crossing_count == 0 && o->area < MOST_TRIANGLES * 0.433 * edge * edge &&
           (!o->has_volume || 1e3 * edge > UNEVEN * filling_edge_mm(o));
}

/* Is a surface finer than a press needs? */
static bool is_needlessly_fine(const organ_request *q, const organ *o)
{
    return !o->has_volume && o->edge < UNEVEN * even_edge(q, o);
}

/* Would it help? */
static bool helps_to_even(const organ_request *q, const organ *o)
{
    return can_be_even(q, o) && (is_coarse(o) || o->is_rounded || o->is_fanned ||
                                 (is_slow(o) && is_needlessly_fine(q, o)));
}

/* A word of the shell's: in quotes where it would be read as something else. */
static void write_word(FILE *out, const char *text)
{
    static const char harmless[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                   "._/+:@%=,-";
    bool is_harmless = *text != '\0';
    for (const char *c = text; *c != '\0'; ++c) {
        is_harmless = is_harmless && ((*c & 0x80) != 0 || strchr(harmless, *c) != NULL);
    }
    if (is_harmless) {
        ss_plain_print(out, "%s", text);
        return;
    }
    ss_plain_print(out, "'");
    for (size_t length; *text != '\0'; text += length) {
        length = strcspn(text, "'");
        ss_plain_print(out, "%.*s", (int)length, text);
        if (text[length] == '\'') {
            ss_plain_print(out, "'\\''");
            ++length;
        }
    }
    ss_plain_print(out, "'");
}

/* A file beside where the user works, named after the mesh: `liver-even.obj`. */
static void write_name(FILE *out, const organ_request *q, const char *end)
{
    const char *slash = strrchr(q->mesh, '/'), *name = slash != NULL ? slash + 1 : q->mesh;
    const char *dot = strrchr(name, '.');
    const int length = dot != NULL && dot > name ? (int)(dot - name) : (int)strlen(name);
    char made[NAME_MAX + 32];
    (void)snprintf(made, sizeof made, "%s%.*s-%s", *name == '-' ? "./" : "", length, name, end);
    write_word(out, made);
}

/* What remesh and tetrahedralize are to begin with: the mesh, or what convert makes of it. */
static void write_start(FILE *out, const organ_request *q, const organ *o)
{
    if (o->has_volume || o->is_repaired) {
        write_name(out, q, o->has_volume ? "surface.obj" : "mended.obj");
    } else {
        write_word(out, q->mesh);
    }
}

static void write_converting(FILE *out, const organ_request *q, const organ *o)
{
    if (o->has_volume || o->is_repaired) {
        ss_plain_print(out, "softsim-mesh convert %s", o->is_repaired ? "--repair " : "");
        write_word(out, q->mesh);
        ss_plain_print(out, " ");
        write_start(out, q, o);
        ss_plain_print(out, "; ");
    }
}

static void write_remeshing(FILE *out, const organ_request *q, const organ *o, const char *made,
                            double edge_mm)
{
    ss_plain_print(out, "softsim-mesh remesh ");
    write_start(out, q, o);
    ss_plain_print(out, " ");
    write_name(out, q, made);
    ss_plain_print(out, " --units %s --edge-mm %.3g; ", o->unit, edge_mm);
}

/* Of a surface that was made, or with NULL of what the commands start with. */
static void write_tetrahedralizing(FILE *out, const organ_request *q, const organ *o,
                                   const char *surface, const char *made)
{
    ss_plain_print(out, "softsim-mesh tetrahedralize ");
    if (surface != NULL) {
        write_name(out, q, surface);
    } else {
        write_start(out, q, o);
    }
    ss_plain_print(out, " ");
    write_name(out, q, made);
    ss_plain_print(out, " --units %s --edge-mm %.3g", o->unit, filling_edge_mm(o));
}

/* The commands that make a mesh of even edges. */
static void write_evening(FILE *out, const organ_request *q, const organ *o)
{
    write_converting(out, q, o);
    write_remeshing(out, q, o, "even.obj", organ_round(1e3 * even_edge(q, o)));
    if (o->has_volume) {
        write_tetrahedralizing(out, q, o, "even.obj", "even.msh");
        ss_plain_print(out, "; ");
    }
}

/* A group of the mesh, which OBJ does not keep. */
static bool is_group(const organ_request *q)
{
    return q->fixed[0] != '{' && strcmp(q->fixed, "away") != 0;
}

/* The same scene of the mesh of even edges. */
static void write_again(FILE *out, const organ_request *q, const organ *o)
{
    static const char *const purpose[] = {[ORGAN_FOR_ACCURACY] = " --for accuracy",
                                          [ORGAN_FOR_SPEED] = " --for speed",
                                          [ORGAN_FOR_FEEL] = ""};
    ss_plain_print(out, "softsim-mesh scene ");
    write_name(out, q, o->has_volume ? "even.msh" : "even.obj");
    ss_plain_print(out, " --tissue %s --units %s%s", q->tissue_name, o->unit, purpose[q->purpose]);
    if (q->model != NULL) {
        ss_plain_print(out, " --model %s", q->model);
    }
    if (strcmp(q->fixed, "away") != 0 && !is_group(q)) {
        ss_plain_print(out, " --fixed ");
        write_word(out, q->fixed);
    }
    if (strcmp(o->axes, "x,y,z") != 0) {
        ss_plain_print(out, " --from %s", o->side);
    }
    if (q->tool_mm > 0.0) {
        ss_plain_print(out, " --tool-mm %g", q->tool_mm);
    }
    ss_plain_print(out, " --out ");
    write_word(out, q->out);
}

/* As an argument of an error, which is to be freed. */
static char *text_of(void (*write)(FILE *, const organ_request *, const organ *),
                     const organ_request *q, const organ *o)
{
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    if (stream != NULL) {
        write(stream, q, o);
        if (fclose(stream) != 0) {
            free(text);
            text = NULL;
        }
    }
    return text;
}

/* Is the surface finer than what fills it is to be? */
static bool is_fine(const organ *o)
{
    return 1e3 * o->edge < UNEVEN * filling_edge_mm(o);
}

/* The commands that fill a surface, whose own edges are made as long as those inside: tetrahedra
 * at shorter ones are many and small. */
static void write_filling(FILE *out, const organ_request *q, const organ *o)
{
    write_converting(out, q, o);
    if (is_fine(o)) {
        write_remeshing(out, q, o, "coarse.obj", filling_edge_mm(o));
    }
    write_tetrahedralizing(out, q, o, is_fine(o) ? "coarse.obj" : NULL, "filled.msh");
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
    if (!o->is_closed) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s %s needs tetrahedra, and %s is a surface with holes, which cannot be "
                          "filled: softsim-mesh convert --repair closes small ones; or --for feel "
                          "--model cnn-energy",
                          option, value, q->mesh);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    char *filling = text_of(write_filling, q, o);
    softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                      "%s %s needs tetrahedra, and %s is a surface: %s, then a scene of what that "
                      "makes; or --for feel --model cnn-energy",
                      option, value, q->mesh,
                      filling != NULL ? filling : "softsim-mesh tetrahedralize");
    free(filling);
    return SOFTSIM_ERROR_ARGUMENT;
}

static void write_even_scene(FILE *out, const organ_request *q, const organ *o)
{
    write_evening(out, q, o);
    write_again(out, q, o);
}

void organ_advise(const organ_request *q, const organ *o, softsim_status status,
                  softsim_error *error)
{
    /* Of a place to press that is not found, mesh and model are no reason. */
    const bool is_of_place = status == SOFTSIM_ERROR_ARGUMENT;
    const bool is_uneven = is_coarse(o) || o->is_fanned || is_needlessly_fine(q, o);
    char *text =
        !is_of_place && is_uneven && can_be_even(q, o) ? text_of(write_even_scene, q, o) : NULL;
    if (text != NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: its edges, %.3g mm in the mean, do not suit a hand's tool: %s",
                          q->mesh, 1e3 * o->edge, text);
    }
    free(text);
    if (q->model != NULL && !is_of_place) {
        softsim_error_add(
            error, SOFTSIM_ERROR_ARGUMENT,
            "--model: scene writes what a tissue says; what %s needs besides goes into "
            "a scene by hand (server/scene/README.md), or leave --model out",
            q->model);
    }
    if (o->part_count > 1 && (strcmp(q->fixed, "away") != 0 || o->loose_count > o->boxed_count)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: of its %d separate parts each is to be held: %sjoin them, or give "
                          "--fixed an entry that reaches each",
                          q->mesh, o->part_count,
                          strcmp(q->fixed, "away") != 0 ? "leave --fixed out, " : "");
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
                       "between them%s; join them if they should be one\n",
                       q->out, q->mesh, o->part_count,
                       o->boxed_count > 0 ? ", and each is held at its side away from the hand"
                                          : "");
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
    } else if (organ_is_stiff(o)) {
        ss_plain_print(
            stderr,
            "softsim-mesh: warning: %s: the force is %.2f times Hertz's of a large, flat body: "
            "linear tetrahedra of this size are too stiff for the tool: a coarser mesh, on which "
            "fem-quadratic is in time, a larger --tool-mm, or --model cnn-energy\n",
            q->out, ratio);
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
        ss_plain_print(stderr, "softsim-mesh: warning: %s: the press is %s: %s%s\n", q->out,
                       softsim_verdict_name(t->verdict), t->reason,
                       t->is_of_place ? "" : "; try another --model, or a mesh of another size");
    }
    if (is_slow(o)) {
        ss_plain_print(
            stderr,
            "softsim-mesh: warning: %s: slower than real time, or hardly faster: a step of %.3g ms "
            "is planned with %.3g ms of a core and took %.3g ms: a server makes longer steps of "
            "it, or falls behind, and forces come out higher than here; take a coarser or more "
            "even mesh%s\n",
            q->out, 1e3 * o->step_s, 1e-3 * o->step_cost_us, 1e-3 * t->step_us,
            q->purpose == ORGAN_FOR_SPEED ? "" : ", or --for speed");
    }
}

/* Its constants are not physical. */
static bool is_scaled(const organ *o)
{
    return o->model->hints != NULL && o->model->hints->write_organ != NULL;
}

static void tell_press(const organ *o)
{
    const trial_result *t = &o->trial;
    (void)printf("  pressed and held: %.3g N at %.3g mm of indentation, %.2f times Hertz's force "
                 "for %.4g Pa and the %.3g mm that the surface went; %.3g N%s at %.3g mm: %s%s%s\n",
                 t->held.force, 1e3 * t->held.indentation, organ_ratio(o),
                 o->tissue->youngs_modulus, 1e3 * t->held.depth, t->deepest.force,
                 t->is_limited ? " (the force limit)" : "", 1e3 * t->deepest.indentation,
                 softsim_verdict_name(t->verdict), t->reason[0] != '\0' ? ": " : "", t->reason);
    if (is_scaled(o)) {
        (void)printf("  %s has no physical constants: they were scaled to Hertz's force, so that a "
                     "thin wall or a cavity is felt as solid tissue\n",
                     o->model->name);
    }
    (void)printf("  beside softsim-bridge's peak force: these are at rest; in motion, at %.3g "
                 "mm/s, the first was %.3g N\n",
                 1e3 * t->speed, t->moving_force);
    (void)printf("  a step of %.3g ms took %.3g ms of a core here (planned: %.3g ms)%s\n",
                 1e3 * o->step_s, 1e-3 * t->step_us, 1e-3 * o->step_cost_us,
                 is_slow(o) ? ": not in real time, or hardly" : "");
}

static void tell_next(const organ_request *q, const organ *o)
{
    if (helps_to_even(q, o)) {
        ss_plain_print(stdout, "next: a mesh that suits the tool%s: ",
                       is_group(q) ? " (it has no groups: the side away from the hand is held)"
                                   : "");
        write_even_scene(stdout, q, o);
        ss_plain_print(stdout, "\n");
    }
    (void)printf("%s: softsimd ", helps_to_even(q, o) ? "as it is" : "next");
    write_word(stdout, q->out);
    (void)printf(", and in another terminal softsim-bridge --device sim --duration 8");
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
    if (o->is_closed && o->crossing_count == 0 && q->purpose != ORGAN_FOR_SPEED &&
        q->model == NULL && (!o->has_volume || (is_scaled(o) && is_fine(o)))) {
        ss_plain_print(stdout, "  for models with physical constants, %s: ",
                       o->has_volume ? "a coarser mesh" : "fill it");
        write_filling(stdout, q, o);
        ss_plain_print(stdout, "\n");
    }
    tell_next(q, o);
}
