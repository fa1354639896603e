/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/slide.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/report.h"
#include "bench/core/sweep.h"
#include "bench/felt/report.h"
#include "output.h"
#include "process.h"
#include "rt/args.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/vec.h"
#include "world/world.h"

enum { SAMPLE_HZ = 1000, MAX_LEGS = 2 + 4 * SS_SLIDE_STOPS, MAX_SPEEDS = 8, SENDER = 1 };
static const double rest_s = 0.2, above_m = 0.003, press_m_s = 0.01, settle_s = 0.5;
static const double stop_s = 0.8, stop_m_s = 0.05, ramp_share = 0.1;
enum { STOP_MS = 20 }; /* mean of a stop's end */
/* Shares of the mean force. */
static const double good_jump = 0.01, good_surface_ripple = 0.01, good_volume_ripple = 0.05,
                    good_rest_loop = 0.02;
static const char *const direction_name[SS_WAY_DIRECTIONS] = {"along", "60deg", "120deg"};
static const char head[] =
    "scene,model,direction,length_mm,edge_mm,speed_mm_s,mean_n,step,jump,ripple,"
    "tilt_deg,loop,loop_at_rest,damping_share,verdict";

/* ---- playing ---- */

/* A part of the path: along the way to `to_m`, at even speed but for its ends, or eased. */
typedef struct leg {
    double to_m, seconds, speed_m_s; /* speed: 0 for one that is eased */
} leg;

static double eased(double share)
{
    return share <= 0.0 ? 0.0 : share >= 1.0 ? 1.0 : 0.5 - 0.5 * cos(M_PI * share);
}

/* A way of `length` at `speed`, which is reached and left over a tenth of it each, by half a
 * cosine. */
static double even_seconds(double length, double speed)
{
    return length / speed * (1.0 + 2.0 * ramp_share);
}

static double even_at(double length, double speed, double time_s)
{
    const double ramp = 2.0 * ramp_share * length / speed, all = even_seconds(length, speed);
    const double t = fmin(fmax(time_s, 0.0), all), end = fmin(t, all - t);
    const double gone = end >= ramp
                            ? speed * (end - 0.5 * ramp)
                            : speed * (0.5 * end - 0.5 * ramp / M_PI * sin(M_PI * end / ramp));
    return t <= 0.5 * all ? gone : length - gone;
}

static double leg_at(const leg *l, double from_m, double time_s)
{
    const double length = fabs(l->to_m - from_m);
    const double gone = l->speed_m_s > 0.0 ? even_at(length, l->speed_m_s, time_s)
                                           : length * eased(time_s / l->seconds);
    return l->to_m >= from_m ? from_m + gone : from_m - gone;
}

/* Plays the legs after the press at the way's beginning; first[k]: the first millisecond of leg k,
 * first[leg_count] the end. */
static softsim_status play_legs(const char *scene, const ss_felt_place *place, const ss_way *way,
                                const ss_felt_run *run, int32_t leg_count, const leg *legs,
                                int32_t *first, ss_slide_trace *out, softsim_error *error)
{
    const double press_s = (0.5 * place->depth_m + above_m) / press_m_s;
    const double height_m = 0.5 * place->depth_m + above_m;
    first[0] = (int32_t)ceil((rest_s + press_s) * SAMPLE_HZ);
    for (int32_t k = 0; k < leg_count; ++k) {
        first[k + 1] = first[k] + (int32_t)ceil(legs[k].seconds * SAMPLE_HZ);
    }
    *out = (ss_slide_trace){.count = first[leg_count]};
    out->way_m = calloc((size_t)out->count + 1, sizeof *out->way_m);
    out->force = calloc((size_t)out->count + 1, sizeof *out->force);
    if (!out->way_m || !out->force) {
        ss_slide_trace_fini(out);
        return ss_memory_fault(error);
    }
    softsim_world *world = ss_felt_world(scene, run, error);
    if (!world) {
        ss_slide_trace_fini(out);
        return error->status;
    }
    double from_m = 0.0;
    for (int32_t k = 0, at = 0; k < out->count; ++k) {
        softsim_force all[SOFTSIM_MAX_PROBES];
        softsim_pose pose = {.utime_us = (int64_t)k * 1000,
                             .sender = SENDER,
                             .seq = k + 1,
                             .probe = place->probe,
                             .force_seq = -1,
                             .velocity = {NAN, NAN, NAN},
                             .applied_force = {NAN, NAN, NAN}};
        while (at < leg_count && k >= first[at + 1]) {
            from_m = legs[at++].to_m;
        }
        const double time_s = (double)(k - first[at]) / SAMPLE_HZ;
        const double pressed = eased(((double)k / SAMPLE_HZ - rest_s) / press_s);
        out->way_m[k] = at < leg_count && time_s > 0.0 ? leg_at(&legs[at], from_m, time_s) : from_m;
        ss_way_at(way, out->way_m[k], pose.position);
        ss_madd3(pose.position, pose.position, height_m * (1.0 - pressed), way->normal);
        memcpy(pose.orientation, place->orientation, sizeof pose.orientation);
        softsim_tick(world, &pose, &place->probe, 1, all);
        ss_copy3(out->force[k], all[place->probe].force);
    }
    softsim_destroy(&world);
    return SOFTSIM_OK;
}

/* What of a leg goes at even speed. */
static ss_way_pass even_part(const ss_slide_trace *trace, int32_t first, double length,
                             double speed_m_s)
{
    const double ramp_ms = 2.0 * ramp_share * length / speed_m_s * SAMPLE_HZ;
    const double all_ms = even_seconds(length, speed_m_s) * SAMPLE_HZ;
    const int32_t from = first + (int32_t)ceil(ramp_ms);
    const int32_t end = first + (int32_t)floor(all_ms - ramp_ms) + 1;
    return (ss_way_pass){end - from, trace->way_m + from,
                         (const double(*)[3])(trace->force + from)};
}

softsim_status ss_slide_play(const char *scene, const ss_felt_place *place, const ss_way *way,
                             const ss_felt_run *run, double speed_m_s, ss_slide_trace *out,
                             softsim_error *error)
{
    const double seconds = even_seconds(way->length_m, speed_m_s);
    const leg legs[] = {{0.0, settle_s, 0.0},
                        {way->length_m, seconds, speed_m_s},
                        {way->length_m, settle_s, 0.0},
                        {0.0, seconds, speed_m_s}};
    int32_t first[5];
    const softsim_status status = play_legs(scene, place, way, run, 4, legs, first, out, error);
    if (status == SOFTSIM_OK) {
        out->forward = even_part(out, first[1], way->length_m, speed_m_s);
        out->back = even_part(out, first[3], way->length_m, speed_m_s);
    }
    return status;
}

void ss_slide_trace_fini(ss_slide_trace *trace)
{
    free(trace->way_m);
    free(trace->force);
    *trace = (ss_slide_trace){.count = 0};
}

softsim_status ss_slide_stop(const char *scene, const ss_felt_place *place, const ss_way *way,
                             const ss_felt_run *run, ss_slide_stops *out, softsim_error *error)
{
    leg legs[MAX_LEGS];
    int32_t first[MAX_LEGS + 1], count = 0;
    double at_m = 0.0;
    *out = (ss_slide_stops){.way_m = {0.0}};
    /* There, to the end, and back. */
    for (int32_t k = 0; k < 2 * SS_SLIDE_STOPS; ++k) {
        const int32_t stop = k < SS_SLIDE_STOPS ? k : 2 * SS_SLIDE_STOPS - 1 - k;
        out->way_m[stop] =
            way->length_m * (ramp_share + (1.0 - 2.0 * ramp_share) * stop / (SS_SLIDE_STOPS - 1));
        if (k == SS_SLIDE_STOPS) {
            legs[count++] = (leg){way->length_m, (way->length_m - at_m) / stop_m_s + stop_s, 0.0};
            at_m = way->length_m;
        }
        legs[count++] = (leg){out->way_m[stop], fabs(out->way_m[stop] - at_m) / stop_m_s, 0.0};
        legs[count++] = (leg){out->way_m[stop], stop_s, 0.0};
        at_m = out->way_m[stop];
    }
    ss_slide_trace trace;
    const softsim_status status =
        play_legs(scene, place, way, run, count, legs, first, &trace, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t k = 0; k < 2 * SS_SLIDE_STOPS; ++k) {
        const bool is_back = k >= SS_SLIDE_STOPS;
        const int32_t end = first[2 * k + 2 + is_back];
        double *force = is_back ? out->back[2 * SS_SLIDE_STOPS - 1 - k] : out->forward[k];
        for (int32_t ms = end - STOP_MS; ms < end; ++ms) {
            ss_madd3(force, force, 1.0 / STOP_MS, trace.force[ms]);
        }
    }
    ss_slide_trace_fini(&trace);
    return SOFTSIM_OK;
}

/* ---- one run: a scene and a direction ---- */

typedef struct slides {
    ss_felt_report base; /* first, as ss_felt_report_run has it */
    const char *speeds;
    double speed_mm_s[MAX_SPEEDS], rate_hz;
    int32_t speed_count;
    bool is_slide;
} slides;

typedef struct job {
    const slides *s;
    const char *scene;
    char name[SS_FELT_NAME_SIZE];
    const char *model;
    bool is_volume;
    int32_t direction;
    ss_felt_place place;
    ss_way way;
    ss_felt_run run;
    ss_slide_stops stops;
    ss_slide_trace trace[MAX_SPEEDS];
    FILE *out;
} job;

/* Largest difference of the stops, N. */
static double rest_loop(const ss_slide_stops *stops)
{
    double most = 0.0;
    for (int32_t k = 0; k < SS_SLIDE_STOPS; ++k) {
        double apart[3];
        ss_sub3(apart, stops->forward[k], stops->back[k]);
        most = fmax(most, ss_norm3(apart));
    }
    return most;
}

static void put_row(const job *j, double speed_mm_s, const ss_way_figures *f, double rest)
{
    const double damping = f->loop > 0.0 ? fmax(0.0, 1.0 - rest / f->loop) : 0.0;
    const double most = j->is_volume ? good_volume_ripple : good_surface_ripple;
    ss_csv_text(j->out, j->name);
    fprintf(j->out, ",%s,%s,%.4g,%.3g,%g,", j->model, direction_name[j->direction],
            1e3 * j->way.length_m, 1e3 * j->way.edge_m, speed_mm_s);
    if (!(f->mean_n > 0.0)) {
        fprintf(j->out, "0,,,,,,,,no force\n");
        return;
    }
    fprintf(j->out, "%.4g,%.3g,%.3g,%.3g,%.3g,%.3g,%.3g,%.2f,%s%s%s%s\n", f->mean_n, f->step,
            f->jump, f->ripple, f->tilt * 180.0 / M_PI, f->loop, rest, damping,
            f->jump > good_jump ? "jumps " : "", f->ripple > most ? "ripples " : "",
            rest > good_rest_loop ? "remembers " : "",
            f->jump > good_jump || f->ripple > most || rest > good_rest_loop ? "" : "good");
}

/* slide-SCENE-DIRECTION.csv: sizes of the forces by place, forward and back at each speed; the
 * stops are rows of their own. */
static softsim_status write_forces(const job *j, softsim_error *error)
{
    enum { ROWS = 400 };
    ss_output csv;
    char name[256], columns[512];
    int used = snprintf(columns, sizeof columns, "way_mm,stop_forward_n,stop_back_n");
    for (int32_t i = 0; i < j->s->speed_count; ++i) {
        used += snprintf(columns + used, sizeof columns - (size_t)used, ",forward_%g_n,back_%g_n",
                         j->s->speed_mm_s[i], j->s->speed_mm_s[i]);
    }
    snprintf(name, sizeof name, "slide-%s-%s", j->name, direction_name[j->direction]);
    const softsim_status status = ss_report_csv_open(&csv, j->s->base.out, name, columns, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t k = 0; k <= ROWS; ++k) {
        const double at =
            j->way.length_m * (ramp_share + (1.0 - 2.0 * ramp_share) * k / (double)ROWS);
        if (k % (ROWS / (SS_SLIDE_STOPS - 1)) == 0) {
            const int32_t stop = k / (ROWS / (SS_SLIDE_STOPS - 1));
            fprintf(csv.file, "%.5g,%.6g,%.6g", 1e3 * at, ss_norm3(j->stops.forward[stop]),
                    ss_norm3(j->stops.back[stop]));
        } else {
            fprintf(csv.file, "%.5g,nan,nan", 1e3 * at);
        }
        for (int32_t i = 0; i < j->s->speed_count; ++i) {
            double force[2][3];
            ss_way_force(&j->trace[i].forward, at, force[0]);
            ss_way_force(&j->trace[i].back, at, force[1]);
            fprintf(csv.file, ",%.6g,%.6g", ss_norm3(force[0]), ss_norm3(force[1]));
        }
        fputc('\n', csv.file);
    }
    return ss_output_commit(&csv, error);
}

static softsim_status play_speeds(job *j, softsim_error *error)
{
    softsim_status status = ss_slide_stop(j->scene, &j->place, &j->way, &j->run, &j->stops, error);
    for (int32_t i = 0; i < j->s->speed_count && status == SOFTSIM_OK; ++i) {
        const double speed_mm_s = j->s->speed_mm_s[i];
        ss_way_figures figures;
        status = ss_slide_play(j->scene, &j->place, &j->way, &j->run, 1e-3 * speed_mm_s,
                               &j->trace[i], error);
        if (status == SOFTSIM_OK &&
            !ss_way_judge(&j->trace[i].forward, &j->trace[i].back, j->way.edge_m, &figures)) {
            status = ss_memory_fault(error);
        }
        if (status == SOFTSIM_OK) {
            put_row(j, speed_mm_s, &figures, rest_loop(&j->stops) / figures.mean_n);
        }
    }
    return status == SOFTSIM_OK ? write_forces(j, error) : status;
}

static softsim_status run_one(const void *context, int32_t index, FILE *out, softsim_error *error)
{
    const slides *s = context;
    ss_scene_model models[SS_MAX_MODELS];
    const int32_t model_count = ss_world_scene_models(models);
    ss_scene *scene = NULL;
    job *j = calloc(1, sizeof *j);
    if (j == NULL) {
        return ss_memory_fault(error);
    }
    j->s = s;
    j->scene = s->base.scenes.path[index / SS_WAY_DIRECTIONS];
    j->direction = index % SS_WAY_DIRECTIONS;
    j->run = (ss_felt_run){
        .rate_hz = s->rate_hz, .set = s->base.set.value, .set_count = s->base.set.count};
    j->out = out;
    ss_felt_name(j->scene, j->name);
    softsim_status status = ss_scene_load(j->scene, s->base.set.value, s->base.set.count, models,
                                          model_count, NULL, &scene, error);
    if (status == SOFTSIM_OK) {
        j->model = models[scene->model_index].name;
        j->is_volume = scene->mesh->tetrahedron_count > 0;
        if (ss_felt_find_place(scene, &j->place) &&
            ss_way_find(scene, &j->place, j->direction, &j->way)) {
            status = play_speeds(j, error);
        } else if (!s->base.scenes.is_bundled) {
            status = SOFTSIM_ERROR_SCENE;
            softsim_error_add(error, status, "%s: has no tool, or no surface to slide on",
                              j->scene);
        }
    }
    ss_scene_destroy(&scene);
    for (int32_t i = 0; i < s->speed_count; ++i) {
        ss_slide_trace_fini(&j->trace[i]);
    }
    free(j);
    return status;
}

/* All that a run depends on. */
static void label(const void *context, int32_t index, char out[SS_SWEEP_NAME_SIZE])
{
    const slides *s = context;
    uint64_t hash = ss_hash_bytes(SS_HASH_START, s->speeds, strlen(s->speeds));
    for (int32_t i = 0; i < s->base.set.count; ++i) {
        hash = ss_hash_bytes(hash, s->base.set.value[i], strlen(s->base.set.value[i]));
    }
    snprintf(out, SS_SWEEP_NAME_SIZE, "%.180s,%s,%g,%016llx",
             s->base.scenes.path[index / SS_WAY_DIRECTIONS],
             direction_name[index % SS_WAY_DIRECTIONS], s->rate_hz, (unsigned long long)hash);
}

/* ---- files ---- */

static softsim_status plot_scene(const slides *s, const ss_sweep_run *run, const char *name,
                                 ss_page *page, softsim_error *error)
{
    ss_output script;
    char picture[160];
    snprintf(picture, sizeof picture, "slide-%s", name);
    const softsim_status status =
        ss_felt_plot_open(&s->base, &script, picture, SS_WAY_DIRECTIONS, 260,
                          "set yrange [0:*]\nset xlabel 'way, mm'\n", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t d = 0; d < SS_WAY_DIRECTIONS; ++d) {
        if (!ss_felt_has_rows(&run[d])) {
            continue;
        }
        fprintf(script.file,
                "set title '%s'\nplot 'slide-%s-%s.csv' skip 1 using 1:2 with points pt 6 lc "
                "rgb 'black' title 'stop, forward', '' skip 1 using 1:3 with points pt 2 lc rgb "
                "'black' title 'stop, back'",
                direction_name[d], name, direction_name[d]);
        for (int32_t i = 0; i < s->speed_count; ++i) {
            fprintf(script.file,
                    ", '' skip 1 using 1:%d with lines lc %d title '%g mm/s', '' skip 1 using 1:%d "
                    "with lines lc %d dt 2 title 'back'",
                    2 * i + 4, i + 1, s->speed_mm_s[i], 2 * i + 5, i + 1);
        }
        fputc('\n', script.file);
    }
    fputs("unset multiplot\n", script.file);
    return ss_page_plot(page, &script, picture,
                        "The force by the tool's place on its way, forward and back.", error);
}

/* The rows of one run as a table's: shares in per cent. */
static void add_rows(ss_page *page, const char *text)
{
    while (*text != '\0') {
        const size_t length = strcspn(text, "\n");
        char line[1024], *at = line;
        ss_row cells = {.count = 0};
        snprintf(line, sizeof line, "%.*s", (int)length, text);
        for (int column = 0; at != NULL; ++column) {
            const char *cell = strsep(&at, ",");
            const bool is_share = (column >= 7 && column <= 9) || (column >= 11 && column <= 13);
            if (is_share && cell[0] != '\0') {
                ss_row_add(&cells, "%.2f", 100.0 * strtod(cell, NULL));
            } else if (column > 1) {
                ss_row_add(&cells, "%s", cell);
            }
        }
        ss_page_table_row(page, cells.count, cells.cell);
        text += length + (text[length] == '\n');
    }
}

static softsim_status write_page(const ss_felt_report *base, const ss_sweep_result *result,
                                 ss_page *page, softsim_error *error)
{
    const slides *s = (const slides *)base;
    static const char *const columns[] = {
        "direction", "way, mm",         "edge, mm",      "mm/s",
        "mean, N",   "step, %",         "ripple, %",     "tilt, deg",
        "loop, %",   "loop at rest, %", "by damping, %", "verdict"};
    softsim_status status = SOFTSIM_OK;
    ss_page_text(
        page,
        "A tool follows a way of 50 mm over the body at rest, or as far as that reaches, at half "
        "the depth of a press, forward and back, in three directions. Figures are of its middle "
        "0.8, in %% of the mean force. Step: largest change from one millisecond to the next, "
        "which "
        "has the body's own shape in it; jump: the same less the mean change of the 5 ms around. "
        "Ripple: amplitude of what is shorter than 2.5 edges of the mesh. Tilt: largest angle of "
        "the force with the same force without ripple. Loop: largest difference of forward and "
        "back at the same place; at rest: the same of five stops of 0.8 s; by damping: the share "
        "of the loop that the stops do not have. Good: jump up to 1 %%, ripple up to 1 %% on a "
        "surface and 5 %% in a volume, loop at rest up to 2 %%.");
    for (int32_t k = 0; k < s->base.scenes.count && status == SOFTSIM_OK; ++k) {
        const ss_sweep_run *run = &result->run[k * SS_WAY_DIRECTIONS];
        char name[SS_FELT_NAME_SIZE];
        bool is_any = false;
        for (int32_t d = 0; d < SS_WAY_DIRECTIONS; ++d) {
            is_any = is_any || run[d].is_lost || ss_felt_has_rows(&run[d]);
        }
        if (!is_any) {
            continue; /* without a tool */
        }
        ss_felt_name(s->base.scenes.path[k], name);
        ss_page_heading(page, name);
        ss_page_table_begin(page, (int32_t)(sizeof columns / sizeof *columns), columns);
        for (int32_t d = 0; d < SS_WAY_DIRECTIONS; ++d) {
            add_rows(page, run[d].is_lost ? "" : run[d].text);
        }
        ss_page_table_end(page);
        ss_felt_page_lost(base, page, run);
        status = plot_scene(s, run, name, page, error);
    }
    return status;
}

/* ---- options ---- */

static ss_args_result parse_options(int argc, char **argv, ss_felt_report *base,
                                    softsim_error *error)
{
    slides *s = (slides *)base;
    s->speeds = "50,200";
    s->rate_hz = 1000.0;
    const ss_arg rows[] = {
        SS_FLAG("--slide", &s->is_slide, "this report"),
        SS_FELT_ROWS(base),
        SS_TEXT("--speeds", &s->speeds, "N,N", "mm/s, 1 to 500 (50,200)"),
        {"--rate-hz", SS_ARG_NUMBER, &s->rate_hz, 10, 1000, "HZ", "of the simulation (1000)"},
    };
    const ss_args_result result = ss_args_parse(
        argc, argv, "--slide [options]",
        "Slides a tool over the surface, forward and back in three directions, and tells whether "
        "the force is smooth and the same both ways.\n"
        "slide.csv: step, jump, ripple, loop, loop_at_rest: shares of mean_n. step: largest change "
        "in "
        "a millisecond, jump: beyond the mean change around it; ripple: amplitude below 2.5 edges "
        "of the mesh; tilt_deg: of the force, by "
        "ripple; loop: largest difference of forward and back at the same place, loop_at_rest: "
        "where the tool stops; damping_share: of the loop, what the stops do not have.",
        rows, (int32_t)(sizeof rows / sizeof rows[0]), NULL, 0, 0, NULL, error);
    if (result == SS_ARGS_RUN) {
        s->speed_count = ss_felt_numbers("--speeds", false, s->speeds, 1.0, 500.0, MAX_SPEEDS,
                                         s->speed_mm_s, error);
    }
    return result;
}

static const char *name_of(int32_t direction)
{
    return direction_name[direction];
}

int ss_felt_slide(int argc, char **argv)
{
    static const ss_felt_kind kind = {"slide",
                                      "softsim: what sliding feels like",
                                      head,
                                      sizeof(slides),
                                      SS_WAY_DIRECTIONS,
                                      name_of,
                                      parse_options,
                                      label,
                                      run_one,
                                      write_page,
                                      NULL};
    return ss_felt_report_run(argc, argv, &kind);
}
