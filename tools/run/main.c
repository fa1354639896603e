/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-run: the daemon's world without LCM, as fast as possible.
 *
 * Poses come from an event log (one tick per well-formed pose, as in the daemon's lockstep, and
 * with the same bits), from a CSV (interpolated at each tick), or not at all (loads only). Row k
 * of the CSV is the state after tick k. Results appear complete or not at all; the CSV and the
 * reactions are recordings (output.h), of which a run that is cut short leaves what it has.
 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "indentation.h"
#include "output.h"
#include "process.h"
#include "rt/args.h"
#include "rt/files.h"
#include "rt/plain.h"
#include "rt/program.h"
#include "rt/progress.h"
#include "rt/real.h"
#include "softsim/log.h"
#include "softsim/softsim.h"
#include "world/omission.h"
#include "world/world.h"

typedef struct run_options {
    const char *scene, *poses, *csv, *reactions, *nodes, *vtk;
    ss_arg_list set, force_include;
    double step_s, duration_s;
    int64_t threads, every;
    bool hash;
} run_options;

typedef struct run {
    run_options options;
    ss_omission omission[SS_MAX_OMISSIONS]; /* of the plan, where some are put back */
    softsim_world *world;
    softsim_state state;
    softsim_poses *log; /* event log; NULL without */
    softsim_path *path; /* pose CSV; NULL without */
    double path_begin, path_end;
    int64_t sender;
    int32_t seq[SOFTSIM_MAX_PROBES];
    ss_output csv, reactions, nodes;
    ss_indentation indentation[SOFTSIM_MAX_PROBES];
    double position_sent[SOFTSIM_MAX_PROBES][3]; /* by the newest pose of each probe */
    double (*position)[3], (*displacement)[3];
    double peak_force;
} run;

static const char csv_header[] =
    "step,time_s,probe,fx,fy,fz,depth_m,energy_j,verdict,indentation_m\n";
static const char csv_help[] =
    "one row per tick and probe, SI units, world frame; without a probe one row a tick\n"
    "with probe -1. Written to OUT.part at least once a second, and OUT when complete:\n"
    "  step           number of the tick, from 1\n"
    "  time_s         simulated; the state is that at the end of the tick\n"
    "  probe          its number\n"
    "  fx,fy,fz       force on the hand at the tool's origin\n"
    "  depth_m        how deep the tool is in the surface that yields to it: what is left\n"
    "                 between the two, not how far it was pressed; 0 without contact\n"
    "  energy_j       of the body, kinetic and elastic\n"
    "  verdict        0 good, 1 guarded, 2 degraded, 3 fault\n"
    "  indentation_m  how far the tool was pressed in since it first touched, along the\n"
    "                 normal: a press of 10 mm is 0.010; 0 without contact";
static const char reactions_help[] =
    "one row per tick and set of held nodes; SI units, world frame:\n"
    "  step, time_s   as in --csv\n"
    "  set            fixed, or the name of a set under prescribed\n"
    "  fx,fy,fz       the support's force on the body";
static const char nodes_help[] = "the final state, one row per node; metres, world frame:\n"
                                 "  node           number in the mesh file, from 0\n"
                                 "  x,y,z          where it is\n"
                                 "  ux,uy,uz       its displacement from rest";

static int print_real(FILE *file, double value)
{
    return fprintf(file, ",%.*g", SS_REAL_DIGITS, value);
}

enum { OUTPUT_COUNT = 4 };

static void list_outputs(const run_options *o, ss_named_file out[OUTPUT_COUNT])
{
    out[0] = (ss_named_file){"--csv", o->csv};
    out[1] = (ss_named_file){"--reactions", o->reactions};
    out[2] = (ss_named_file){"--nodes", o->nodes};
    out[3] = (ss_named_file){"--vtk", o->vtk};
}

static ss_args_result parse(int argc, char **argv, run_options *out, softsim_error *error)
{
    run_options o = {.threads = 1};
    const ss_arg rows[] = {
        SS_TEXT("--poses", &o.poses, "LOG|CSV",
                "probe poses: an event log, or time_s,probe,x,y,z,qw,qx,qy,qz,buttons; of a\n"
                "damaged log what is left, exit 1; what its server refused is left out"),
        {"--dt", SS_ARG_NUMBER, &o.step_s, 1e-7, 1.0, "S",
         "outer step and tick (default: the scene's haptic period); not with an event log"},
        {"--duration", SS_ARG_NUMBER, &o.duration_s, 1e-6, 1e9, "S",
         "simulated seconds (default: to the end of the poses)"},
        {"--threads", SS_ARG_INTEGER, &o.threads, 1, 64, "N", "results do not depend on it"},
        SS_LIST("--set", &o.set, "PATH=VALUE", "overrides one scene value"),
        SS_LIST("--force-include", &o.force_include, "NAME",
                "has what the plan leaves out all the same, by its name in softsimd --explain;\n"
                "softsim-bench ablation checks that results stay as they are"),
        SS_TEXT("--csv", &o.csv, "OUT", csv_help),
        SS_TEXT("--reactions", &o.reactions, "OUT", reactions_help),
        SS_TEXT("--nodes", &o.nodes, "OUT", nodes_help),
        SS_TEXT("--vtk", &o.vtk, "DIR", "the surface as legacy VTK, every --every"),
        {"--every", SS_ARG_INTEGER, &o.every, 1, 1e9, "N", "ticks between VTK files"},
        SS_FLAG("--hash", &o.hash, "prints the final state hash"),
    };
    int32_t count = 0;
    const ss_args_result result = ss_args_parse(
        argc, argv, "[options] SCENE.yaml", "Runs a scene without LCM, as fast as possible.", rows,
        (int32_t)(sizeof rows / sizeof *rows), &o.scene, 1, 1, &count, error);
    *out = o;
    if (result != SS_ARGS_RUN) {
        return result;
    }
    if (!o.poses && o.duration_s <= 0.0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "nothing says when to end; give --poses FILE or --duration S");
    }
    if ((o.vtk != NULL) != (o.every > 0)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--vtk and --every go together");
    }
    if (error->fault_count == 0) {
        const ss_named_file in[] = {{"the scene", o.scene}, {"the --poses file", o.poses}};
        ss_named_file outputs[OUTPUT_COUNT];
        list_outputs(&o, outputs);
        (void)ss_files_check(in, 2, outputs, OUTPUT_COUNT, error);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : SS_ARGS_RUN;
}

/* An event log starts with its sync word; everything else is read as a CSV, whose faults say what
 * is wrong. */
static bool is_event_log(const char *path)
{
    static const unsigned char sync[4] = {0xed, 0xa1, 0xda, 0x01};
    unsigned char head[4] = {0};
    const char *why = NULL;
    FILE *file = ss_files_open_stream(path, NULL, &why);
    const bool is_log = file && fread(head, 1, 4, file) == 4 && memcmp(head, sync, 4) == 0;
    if (file) {
        fclose(file);
    }
    return is_log;
}

/* A log of something else would be played to its end at once. */
static softsim_status find_poses(run *r, softsim_error *error)
{
    softsim_pose_event event;
    char note[256] = ""; /* said when it is played */
    softsim_poses_result next;
    do {
        next = softsim_poses_next(r->log, &event, note, sizeof note);
    } while (next == SOFTSIM_POSES_NOTE);
    if (next == SOFTSIM_POSES_END) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s: no probe poses: %s", r->options.poses,
                          note[0] != '\0' ? note : "no record on a channel ..._PROBE_<n>");
        return SOFTSIM_ERROR_FORMAT;
    }
    softsim_poses_rewind(r->log);
    return SOFTSIM_OK;
}

static softsim_status open_poses(run *r, softsim_error *error)
{
    const char *path = r->options.poses;
    if (!path) {
        return SOFTSIM_OK;
    }
    if (is_event_log(path)) {
        if (r->options.step_s > 0.0) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "--dt: an event log gives one tick of the scene's haptic period per "
                              "pose; leave --dt out");
            return SOFTSIM_ERROR_ARGUMENT;
        }
        return softsim_poses_open(path, 1000.0, &r->log, error) == SOFTSIM_OK ? find_poses(r, error)
                                                                              : error->status;
    }
    const softsim_status status = softsim_path_load(path, &r->path, error);
    if (status == SOFTSIM_OK) {
        char note[80];
        softsim_path_range(r->path, -1, &r->path_begin, &r->path_end);
        if (softsim_path_note(r->path, note, sizeof note)) {
            ss_plain_print(stderr, "softsim-run: %s: %s\n", path, note);
        }
    }
    return status;
}

/* ---- output ---- */

static const ss_scene *scene_of(const run *r)
{
    return ss_world_of(r->world)->scene;
}

static void write_row(run *r, const softsim_force force[SOFTSIM_MAX_PROBES])
{
    const softsim_state *s = &r->state;
    FILE *file = r->csv.file;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (s->probes & (1u << p)) {
            const bool is_contact = force[p].flags & SOFTSIM_FORCE_CONTACT;
            fprintf(file, "%lld,%.17g,%d", (long long)s->tick, s->time_s, p);
            for (int axis = 0; axis < 3; ++axis) {
                print_real(file, force[p].force[axis]);
            }
            print_real(file, is_contact ? force[p].depth : 0.0);
            print_real(file, s->kinetic_j + s->elastic_j);
            fprintf(file, ",%d", (int)s->verdict);
            print_real(file,
                       ss_indentation_take(&r->indentation[p], &force[p], r->position_sent[p]));
            fputc('\n', file);
        }
    }
    if (s->probes == 0) {
        fprintf(file, "%lld,%.17g,-1,0,0,0,0", (long long)s->tick, s->time_s);
        print_real(file, s->kinetic_j + s->elastic_j);
        fprintf(file, ",%d,0\n", (int)s->verdict);
    }
}

static void write_reactions(run *r)
{
    for (int32_t set = -1; set < softsim_prescribed_count(r->world); ++set) {
        double force[3];
        softsim_read_reaction(r->world, set, force);
        fprintf(r->reactions.file, "%lld,%.17g,%s", (long long)r->state.tick, r->state.time_s,
                softsim_prescribed_name(r->world, set));
        for (int axis = 0; axis < 3; ++axis) {
            print_real(r->reactions.file, force[axis]);
        }
        fputc('\n', r->reactions.file);
    }
}

static void write_nodes(run *r)
{
    FILE *file = r->nodes.file;
    softsim_read_nodes(r->world, r->position, r->displacement, NULL);
    for (int32_t i = 0; i < r->state.node_count; ++i) {
        fprintf(file, "%d", i);
        for (int axis = 0; axis < 3; ++axis) {
            print_real(file, r->position[i][axis]);
        }
        for (int axis = 0; axis < 3; ++axis) {
            print_real(file, r->displacement[i][axis]);
        }
        fputc('\n', file);
    }
}

/* Legacy VTK, ASCII POLYDATA: the deformed surface with its displacement. */
static softsim_status write_vtk(run *r, softsim_error *error)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/surface_%08lld.vtk", r->options.vtk, (long long)r->state.tick);
    ss_output output = {0};
    const ss_named_file out = {"--vtk", path};
    if (!ss_scene_check_outputs(scene_of(r), &out, 1, error) ||
        ss_output_open(&output, path, error) != SOFTSIM_OK) {
        return error->status;
    }
    softsim_read_nodes(r->world, r->position, r->displacement, NULL);
    const int32_t nodes = r->state.node_count;
    const int32_t triangles = softsim_triangle_count(r->world);
    const int32_t(*triangle)[3] = softsim_triangles(r->world);
    FILE *file = output.file;
    fprintf(file, "# vtk DataFile Version 3.0\nsoftsim t = %.9g s\nASCII\nDATASET POLYDATA\n",
            r->state.time_s);
    fprintf(file, "POINTS %d double\n", nodes);
    for (int32_t i = 0; i < nodes; ++i) {
        fprintf(file, "%.9g %.9g %.9g\n", r->position[i][0], r->position[i][1], r->position[i][2]);
    }
    fprintf(file, "POLYGONS %d %d\n", triangles, 4 * triangles);
    for (int32_t t = 0; t < triangles; ++t) {
        fprintf(file, "3 %d %d %d\n", triangle[t][0], triangle[t][1], triangle[t][2]);
    }
    fprintf(file, "POINT_DATA %d\nVECTORS displacement double\n", nodes);
    for (int32_t i = 0; i < nodes; ++i) {
        fprintf(file, "%.9g %.9g %.9g\n", r->displacement[i][0], r->displacement[i][1],
                r->displacement[i][2]);
    }
    return ss_output_commit(&output, error);
}

/* Nothing where no path is given. */
static softsim_status open_recording(ss_output *output, const char *path, const char *header,
                                     softsim_error *error)
{
    const softsim_status status = path ? ss_output_record(output, path, error) : SOFTSIM_OK;
    if (status == SOFTSIM_OK && path) {
        ss_output_tell_kept(output->kept, output->temporary, "softsim-run");
        fputs(header, output->file);
    }
    return status;
}

/* Before the first tick, so that a run is not for nothing. */
static softsim_status open_outputs(run *r, softsim_error *error)
{
    softsim_status status = open_recording(&r->csv, r->options.csv, csv_header, error);
    if (status == SOFTSIM_OK) {
        status = open_recording(&r->reactions, r->options.reactions, "step,time_s,set,fx,fy,fz\n",
                                error);
    }
    if (status == SOFTSIM_OK && r->options.nodes) {
        status = ss_output_open(&r->nodes, r->options.nodes, error);
    }
    if (status == SOFTSIM_OK && r->options.nodes) {
        fputs("node,x,y,z,ux,uy,uz\n", r->nodes.file);
    }
    if (status == SOFTSIM_OK && r->options.vtk && mkdir(r->options.vtk, 0777) != 0 &&
        errno != EEXIST) {
        status = SOFTSIM_ERROR_FILE;
        softsim_error_add(error, status, "--vtk: cannot make the folder %s: %s", r->options.vtk,
                          strerror(errno));
    }
    return status;
}

/* ---- the run ---- */

/* The poses of the coming tick: one of the log, or the CSV's at that time. -1 when the poses end.
 * Notes about damage go to stderr. */
static int32_t next_poses(run *r, softsim_pose pose[SOFTSIM_MAX_PROBES],
                          int32_t channel[SOFTSIM_MAX_PROBES])
{
    int32_t count = 0;
    if (r->log) {
        for (;;) {
            softsim_pose_event event;
            char note[256];
            switch (softsim_poses_next(r->log, &event, note, sizeof note)) {
            case SOFTSIM_POSES_END:
                return -1;
            case SOFTSIM_POSES_NOTE:
                ss_plain_print(stderr, "softsim-run: %s: %s\n", r->options.poses, note);
                continue;
            case SOFTSIM_POSES_POSE:
                if (event.channel_probe < 0 || event.channel_probe >= SOFTSIM_MAX_PROBES) {
                    continue;
                }
                pose[0] = event.pose;
                channel[0] = event.channel_probe;
                softsim_poses_restamp(&pose[0], r->sender, ++r->seq[channel[0]]);
                return 1;
            }
        }
    }
    if (r->path) {
        const double time = (double)(r->state.tick + 1) * r->state.period_s + r->path_begin;
        if (r->options.duration_s <= 0.0 && time > r->path_end + 0.5 * r->state.period_s) {
            return -1;
        }
        for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
            if (softsim_path_sample(r->path, p, time, &pose[count])) {
                softsim_poses_restamp(&pose[count], r->sender, ++r->seq[p]);
                channel[count++] = p;
            }
        }
    }
    return count;
}

/* A full disk ends a run when it is met, however much of the run is left. */
static bool is_written(run *r)
{
    const bool is_good = ss_output_pace(&r->csv);
    return ss_output_pace(&r->reactions) && is_good;
}

static softsim_status run_ticks(run *r, softsim_error *error)
{
    softsim_pose pose[SOFTSIM_MAX_PROBES];
    int32_t channel[SOFTSIM_MAX_PROBES];
    softsim_force force[SOFTSIM_MAX_PROBES];
    softsim_read(r->world, &r->state);
    const bool reads_each = r->csv.file || r->reactions.file || r->options.vtk;
    while (r->options.duration_s <= 0.0 || (double)(r->state.tick + 1) * r->state.period_s <=
                                               r->options.duration_s + 0.5 * r->state.period_s) {
        const int32_t count = next_poses(r, pose, channel);
        if (count < 0) {
            break;
        }
        if (ss_process_is_stopped()) {
            softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "stopped at %.6g s, before its end",
                              (double)r->state.tick * r->state.period_s);
            return error->status;
        }
        softsim_tick(r->world, pose, channel, count, force);
        for (int32_t i = 0; i < count; ++i) {
            memcpy(r->position_sent[channel[i]], pose[i].position, sizeof pose[i].position);
        }
        ++r->state.tick;
        for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
            const double *f = force[p].force;
            r->peak_force = fmax(r->peak_force, sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]));
        }
        if (r->state.tick % 500 == 0) {
            ss_progress_stage("simulated %.2f s, %.3f N peak",
                              (double)r->state.tick * r->state.period_s, r->peak_force);
        }
        if (!reads_each) {
            continue;
        }
        softsim_read(r->world, &r->state);
        if (r->csv.file) {
            write_row(r, force);
        }
        if (r->reactions.file) {
            write_reactions(r);
        }
        if (!is_written(r)) {
            break; /* what closes the files says why */
        }
        if (r->options.vtk && r->state.tick % r->options.every == 0 &&
            write_vtk(r, error) != SOFTSIM_OK) {
            return error->status;
        }
    }
    softsim_read(r->world, &r->state);
    return SOFTSIM_OK;
}

static void print_summary(const run *r)
{
    const softsim_state *s = &r->state;
    int64_t refused = 0;
    fprintf(stderr,
            "softsim-run: %lld ticks, %lld steps of %.6g ms, %.6g s simulated; %lld poses, ",
            (long long)s->tick, (long long)s->step, 1e3 * s->simulation_period_s, s->time_s,
            (long long)s->poses_received);
    for (int i = 0; i < SOFTSIM_REFUSED_COUNT; ++i) {
        refused += s->poses_refused[i];
    }
    fprintf(stderr, "%lld refused", (long long)refused);
    const char *before = " (";
    for (int i = 0; i < SOFTSIM_REFUSED_COUNT; ++i) {
        if (s->poses_refused[i] != 0) {
            fprintf(stderr, "%s%s %lld", before, softsim_refusal_name(i),
                    (long long)s->poses_refused[i]);
            before = ", ";
        }
    }
    fprintf(stderr, "%s; peak force %.4g N; step us p50 %.1f p99 %.1f; worst verdict %s%s%s\n",
            refused != 0 ? ")" : "", r->peak_force, s->step_us[0], s->step_us[1],
            softsim_verdict_name(s->worst_verdict), *s->worst_reason ? ": " : "", s->worst_reason);
    fprintf(stderr, "softsim-run: energy J kinetic %.4g elastic %.4g dissipated %.4g work %.4g\n",
            s->kinetic_j, s->elastic_j, s->dissipated_j, s->work_j);
}

/* A tick a pose is what makes the bits those of the daemon's lockstep. */
static void tell_turns(const run *r)
{
    int32_t probes = 0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        probes += r->seq[k] > 0;
    }
    if (r->log && probes > 1) {
        ss_plain_print(
            stderr,
            "softsim-run: %s has poses of %d probes, each takes a tick as in lockstep: tools "
            "that moved at once move in turn, and slower; a CSV of poses moves them at once\n",
            r->options.poses, probes);
    }
}

static softsim_config config_of(const run *r)
{
    softsim_config config = softsim_default_config();
    config.set = r->options.set.value;
    config.set_count = r->options.set.count;
    config.threads = (int32_t)r->options.threads;
    config.step_s = r->options.step_s;
    return config;
}

/* The values that put back what was asked for, as if they were given with --set. */
static softsim_status put_back(run *r, softsim_error *error)
{
    const ss_arg_list *names = &r->options.force_include;
    ss_arg_list *set = &r->options.set;
    if (names->count == 0) {
        return SOFTSIM_OK;
    }
    const softsim_config config = config_of(r);
    int32_t count = 0;
    const softsim_status status =
        ss_omissions_of_scene(r->options.scene, &config, r->omission, &count, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < names->count; ++i) {
        const ss_omission *found = ss_omission_find(r->omission, count, names->value[i], error);
        for (int32_t k = 0; found != NULL && k < found->value_count; ++k) {
            if (set->count == SS_ARG_LIST_MAX) {
                softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                                  "--force-include and --set: more than %d values",
                                  SS_ARG_LIST_MAX);
                return error->status;
            }
            set->value[set->count++] = found->value[k];
        }
    }
    return error->fault_count > 0 ? error->status : SOFTSIM_OK;
}

static softsim_status execute(run *r, softsim_error *error)
{
    if (put_back(r, error) != SOFTSIM_OK) {
        return error->status;
    }
    softsim_config config = config_of(r);
    if (config.step_s == 0.0 && !r->options.poses) {
        /* Loads only: step and tick are one, the haptic period. */
        softsim_world *world = softsim_create(r->options.scene, &config, error);
        if (!world) {
            return error->status;
        }
        softsim_read(world, &r->state);
        if (r->state.simulation_period_s == r->state.period_s) {
            r->world = world;
        } else {
            config.step_s = r->state.period_s;
            softsim_destroy(&world);
        }
    }
    if (!r->world) {
        r->world = softsim_create(r->options.scene, &config, error);
    }
    if (!r->world) {
        return error->status;
    }
    ss_named_file outputs[OUTPUT_COUNT];
    list_outputs(&r->options, outputs);
    if (!ss_scene_check_outputs(scene_of(r), outputs, OUTPUT_COUNT, error)) {
        return error->status;
    }
    softsim_read(r->world, &r->state);
    r->position = calloc((size_t)r->state.node_count, sizeof *r->position);
    r->displacement = calloc((size_t)r->state.node_count, sizeof *r->displacement);
    softsim_status status = r->position && r->displacement ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    if (status == SOFTSIM_OK) {
        status = open_outputs(r, error);
    }
    return status;
}

/* Were records skipped, other than a last one that is cut, or are they of two hands? */
static bool is_damaged(const run *r)
{
    return r->log && (softsim_poses_is_damaged(r->log) || softsim_poses_is_mixed(r->log));
}

/* What was recorded is complete, or kept and named where the run was cut short. */
static softsim_status finish(run *r, softsim_status status, softsim_error *error)
{
    ss_output *const recorded[] = {&r->csv, &r->reactions};
    if (status == SOFTSIM_OK && is_damaged(r)) {
        status = SOFTSIM_ERROR_FORMAT;
        softsim_error_add(error, status, "%s: %s", r->options.poses,
                          softsim_poses_is_damaged(r->log)
                              ? "records are missing; what is left was played"
                              : "poses of two senders are mixed; all of them were played");
    }
    const bool is_complete = status == SOFTSIM_OK && is_written(r);
    for (int i = 0; i < 2; ++i) {
        if (!is_complete && recorded[i]->reason == 0) {
            ss_output_keep(recorded[i], error);
        } else if (ss_output_commit(recorded[i], error) != SOFTSIM_OK) {
            status = error->status;
        }
    }
    if (status == SOFTSIM_OK && r->options.nodes) {
        write_nodes(r);
        status = ss_output_commit(&r->nodes, error);
    }
    return status;
}

int main(int argc, char **argv)
{
    static softsim_error error;
    static run r;
    ss_program_begin();
    int exit_code = 0;
    if (!ss_args_may_run(argv[0], parse(argc, argv, &r.options, &error), &error, &exit_code)) {
        return ss_program_finish(argv[0], exit_code);
    }
    r.sender = 1;
    ss_progress_begin("softsim-run", "loading %s", r.options.scene);
    const bool is_ready = open_poses(&r, &error) == SOFTSIM_OK && execute(&r, &error) == SOFTSIM_OK;
    ss_process_catch_stop(); /* from here on: a long load is simply ended */
    if (!is_ready) {
        exit_code = 2;
    } else if (finish(&r, run_ticks(&r, &error), &error) != SOFTSIM_OK) {
        exit_code = 1;
    }
    ss_progress_end();
    if (exit_code == 0 && r.options.hash) {
        printf("%016llx\n", (unsigned long long)softsim_hash(r.world));
        (void)fflush(stdout); /* a failure stays: ss_program_finish tells it */
    }
    /* Results are out: one who does not read the rest holds up nothing. */
    if ((exit_code == 0 || (is_ready && is_damaged(&r))) && ss_program_can_tell()) {
        print_summary(&r);
        tell_turns(&r);
    }
    if (exit_code != 0) {
        ss_args_print_error(argv[0], &error);
    }
    ss_output_abandon(&r.csv);
    ss_output_abandon(&r.reactions);
    ss_output_abandon(&r.nodes);
    softsim_poses_close(&r.log);
    softsim_path_free(&r.path);
    softsim_destroy(&r.world);
    free(r.position);
    free(r.displacement);
    return ss_program_finish(argv[0], exit_code);
}
