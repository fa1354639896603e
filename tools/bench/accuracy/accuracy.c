/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench accuracy: every model on every mesh of problems with trusted solutions, error
 * against run time. What is measured: the field and the force against the reference (case/norms.h),
 * the thread CPU time of a step of 1 ms of the product's own world, and the time until the body has
 * come to rest. What is not: loads or materials that a model refuses; those rows say so.
 */
#include <dirent.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/accuracy/report.h"
#include "bench/bench.h"
#include "bench/core/child.h"
#include "bench/core/sweep.h"
#include "case/run.h"
#include "case/scratch.h"
#include "models/model.h"
#include "output.h"
#include "process.h"
#include "rt/args.h"
#include "rt/each.h"
#include "rt/files.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "world/world.h"

enum { MAX_NAMES = 64, QUICK_MESHES = 2, QUICK_NODES = 2000 };
static const double quick_cpu_s = 3.0, full_cpu_s = 180.0;
/* Here, or in a folder above the program: of the source tree it was built in. */
static const char *const standard[] = {"tests/reference", NULL};

/* ---- options ---- */

/* The report may be no file that the command names. */
static void check_outputs(const ss_accuracy_options *o, softsim_error *error)
{
    static const char *const names[] = {"accuracy.csv", "accuracy.html", "dynamics.csv",
                                        "case/case.yaml"};
    enum { COUNT = sizeof names / sizeof *names };
    char path[COUNT][SS_ACCURACY_PATH + 32];
    ss_named_file in[SS_ARG_LIST_MAX + 1] = {{"the --scene file", o->scene}}, out[COUNT];
    for (int32_t k = 0; k < o->compare.count; ++k) {
        in[k + 1] = (ss_named_file){"a --compare file", o->compare.value[k]};
    }
    for (int k = 0; k < COUNT; ++k) {
        snprintf(path[k], sizeof path[k], "%s/%s", o->out, names[k]);
        out[k] = (ss_named_file){"--out", path[k]};
    }
    (void)ss_files_check(in, o->compare.count + 1, out, COUNT, error);
}

static ss_args_result parse(int argc, char **argv, ss_accuracy_options *out, softsim_error *error)
{
    ss_accuracy_options o = {.out = "accuracy-report", .jobs = 1};
    const ss_arg rows[] = {
        SS_LIST("--case", &o.cases, "DIR",
                "a reference problem, a folder with a case.yaml; may be given again (all of "
                "tests/reference)"),
        SS_TEXT("--scene", &o.scene, "SCENE.yaml",
                "a scene in place of cases, with gravity, one pressure or one prescribed set: its "
                "reference is made by refinement, and judged"),
        SS_TEXT("--model", &o.model, "A,B", "these models only"),
        SS_LIST("--set", &o.set, "KEY=VALUE",
                "a parameter of physical models that the case does not give, as "
                "locking_cure=nodal-pressure; may be given again"),
        SS_TEXT("--mesh", &o.mesh, "M,N", "these meshes of the cases only"),
        SS_FLAG("--quick", &o.is_quick,
                "the two coarsest meshes, up to 2000 nodes, and the first and last level"),
        {"--budget-us", SS_ARG_NUMBER, &o.budget_us, 1e-3, 1e9, "N",
         "names the most accurate choice whose step takes no longer"},
        SS_LIST("--compare", &o.compare, "FILE.csv",
                "rows of other programs, with the columns of accuracy.csv, into the same pictures"),
        {"--jobs", SS_ARG_INTEGER, &o.jobs, 1, SS_SWEEP_MAX_JOBS, "N", "processes at a time (1)"},
        SS_TEXT("--out", &o.out, "DIR", "for the report (accuracy-report)"),
    };
    const ss_args_result result =
        SS_ARGS_OPTIONS(argc, argv, "[options]",
                        "Measures the error of every model against its run time on problems with "
                        "trusted solutions. The same command goes on where it was killed, and runs "
                        "under mpirun.",
                        rows, error);
    *out = o;
    if (result == SS_ARGS_RUN && strlen(o.out) > SS_ACCURACY_PATH - 300) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--out: too long a path");
    }
    if (result == SS_ARGS_RUN && o.scene != NULL && o.cases.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--scene stands in place of --case; leave one out");
    }
    if (result == SS_ARGS_RUN && error->fault_count == 0) {
        check_outputs(&o, error);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : result;
}

static void check_models(const ss_accuracy_options *o, softsim_error *error)
{
    for (const char *at = o->model; at != NULL;) {
        char name[64];
        const size_t length = strcspn(at, ",");
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        if (ss_model_find(name) == NULL) {
            char known[256] = "";
            int32_t count = 0;
            const ss_model_class *const *table = ss_model_table(&count);
            for (int32_t i = 0; i < count; ++i) {
                const size_t used = strlen(known);
                snprintf(known + used, sizeof known - used, " %s", table[i]->name);
            }
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "--model: '%s' is not a model of this program; it has:%s", name,
                              known);
        }
        at = at[length] == ',' ? at + length + 1 : NULL;
    }
}

/* Each must be a parameter of a model that is to run. */
static void check_sets(const ss_accuracy_options *o, softsim_error *error)
{
    for (int32_t i = 0; i < o->set.count; ++i) {
        const char *set = o->set.value[i];
        const char *equals = strchr(set, '=');
        int32_t count = 0, takers = 0;
        const ss_model_class *const *table = ss_model_table(&count);
        for (int32_t k = 0; k < count; ++k) {
            const ss_model_class *model = ss_accuracy_model_find(table[k]->name);
            takers += model != NULL && ss_accuracy_is_listed(o->model, model->name) &&
                      ss_accuracy_model_takes(model, set);
        }
        if (equals == NULL || equals[1] == '\0' || strpbrk(set, "\n\r#") != NULL || takers == 0) {
            softsim_error_add(
                error, SOFTSIM_ERROR_ARGUMENT,
                "--set: '%s' is not KEY=VALUE with a parameter that is left to choose "
                "of a physical model that runs; softsimd --print-config shows them",
                set);
        }
    }
}

/* ---- cases ---- */

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

/* Every folder of `parent` with a case.yaml; true when there was one. */
static bool find_cases(void *context, const char *parent)
{
    ss_accuracy *r = context;
    DIR *folder = opendir(parent);
    if (folder == NULL) {
        return false;
    }
    for (const struct dirent *at = readdir(folder); at != NULL; at = readdir(folder)) {
        char path[SS_CASE_PATH + 300];
        const int length = snprintf(path, sizeof path, "%s/%s/case.yaml", parent, at->d_name);
        if (at->d_name[0] != '.' && length < SS_CASE_PATH && access(path, R_OK) == 0 &&
            r->found_count < SS_ACCURACY_MAX_CASES) {
            snprintf(r->found[r->found_count++], SS_CASE_PATH, "%s/%s", parent, at->d_name);
        }
    }
    closedir(folder);
    qsort(r->found, (size_t)r->found_count, sizeof r->found[0], by_name);
    return r->found_count > 0;
}

/* The scene as a case of the report's own. */
static softsim_status make_scene_case(ss_accuracy *r, softsim_error *error)
{
    char *path = r->found[r->found_count++];
    if (snprintf(path, SS_CASE_PATH, "%s/case", r->o.out) >= SS_CASE_PATH) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--out: too long a path");
        return SOFTSIM_ERROR_ARGUMENT;
    }
    return ss_accuracy_scene(r->o.scene, path, r->o.is_quick, &r->worth, error);
}

/* A file as it is read; of one that cannot be read its job will say so. */
static uint64_t add_file(uint64_t hash, const char *folder, const char *name)
{
    char path[2 * SS_CASE_PATH];
    size_t size = 0;
    softsim_error ignored = {.status = SOFTSIM_OK};
    if (name[0] == '\0') {
        return hash;
    }
    ss_case_join(folder, name, path, sizeof path);
    char *text = ss_table_read_file(path, &size, &ignored);
    hash = ss_hash_bytes(hash, &size, sizeof size);
    hash = ss_hash_bytes(hash, text, size);
    free(text);
    return hash;
}

static uint64_t add_meshes(uint64_t hash, const ss_case *c, bool on_surface, bool has_solution)
{
    int32_t count = 0;
    const ss_case_mesh *mesh = ss_case_meshes(c, on_surface, &count);
    for (int32_t i = 0; i < count; ++i) {
        hash = add_file(hash, c->mesh_folder, on_surface ? mesh[i].surface : mesh[i].volume);
        hash = add_file(hash, c->mesh_folder, mesh[i].sets);
        for (int32_t m = 0; m < c->material_count && has_solution; ++m) {
            hash = add_file(hash, c->mesh_folder, mesh[i].reference[m]);
        }
    }
    return hash;
}

/* Of all that a case says, and of what is set beside it. `has_solution` false: but for what follows
 * from the rest. */
static uint64_t digest_of(const ss_case *c, bool has_solution, const ss_arg_list *set)
{
    uint64_t hash = add_file(0, c->folder, "case.yaml");
    for (int32_t i = 0; i < set->count; ++i) {
        hash = ss_hash_bytes(hash, set->value[i], strlen(set->value[i]) + 1);
    }
    hash = add_file(hash, c->mesh_folder, "case.yaml");
    hash = add_meshes(add_meshes(hash, c, false, has_solution), c, true, has_solution);
    for (int32_t i = 0; i < c->level_count && has_solution; ++i) {
        hash = ss_hash_bytes(hash, &c->level[i].force, sizeof c->level[i].force);
    }
    hash = ss_hash_bytes(hash, &c->first_frequency, sizeof c->first_frequency);
    for (int32_t i = 0; i < c->step_count; ++i) {
        const ss_case_step *step = &c->step[i];
        hash = ss_hash_bytes(hash, step->time, (size_t)step->count * sizeof *step->time);
        hash = ss_hash_bytes(hash, step->u, (size_t)step->count * sizeof *step->u);
    }
    return hash;
}

static softsim_status load_cases(ss_accuracy *r, softsim_error *error)
{
    if (r->o.scene != NULL) {
        const softsim_status status = make_scene_case(r, error);
        if (status != SOFTSIM_OK) {
            return status;
        }
    } else if (r->o.cases.count == 0) {
        ss_child_look_above(standard, find_cases, r);
    }
    const int32_t count = r->o.cases.count > 0 ? r->o.cases.count : r->found_count;
    if (count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "no %s with reference problems is near; name them with --case DIR",
                          standard[0]);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    r->plan.c = calloc((size_t)count, sizeof *r->plan.c);
    if (r->plan.c == NULL) {
        return ss_memory_fault(error);
    }
    for (int32_t k = 0; k < count; ++k) {
        ss_case *c = &r->plan.c[r->plan.case_count++];
        ss_case_load(r->o.cases.count > 0 ? r->o.cases.value[k] : r->found[k], c, error);
        for (int32_t i = 0; i < k; ++i) {
            if (error->fault_count == 0 && strcmp(c->name, r->plan.c[i].name) == 0) {
                softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s and %s are both called '%s'",
                                  r->plan.c[i].folder, c->folder, c->name);
            }
        }
        /* What a scene's case has for a solution is made again by every start, and may be rounded
         * otherwise by another machine. */
        r->plan.digest[k] =
            error->fault_count == 0 ? digest_of(c, r->o.scene == NULL, &r->o.set) : 0;
    }
    return error->fault_count > 0 ? error->status : SOFTSIM_OK;
}

/* ---- jobs ---- */

static softsim_status add_job(ss_accuracy_plan *plan, ss_accuracy_job job, softsim_error *error)
{
    if (plan->job_count % 64 == 0) {
        ss_accuracy_job *more =
            realloc(plan->job, (size_t)(plan->job_count + 64) * sizeof *plan->job);
        if (more == NULL) {
            return ss_memory_fault(error);
        }
        plan->job = more;
    }
    plan->job[plan->job_count++] = job;
    return SOFTSIM_OK;
}

/* In a hurry: the coarsest meshes, and of these not those that are fine already. */
static bool is_quick_mesh(const ss_case *c, const ss_case_mesh *mesh, int32_t index,
                          bool on_surface)
{
    ss_case_body body;
    softsim_error ignored = {.status = SOFTSIM_OK}; /* ss_accuracy_check_bodies says it */
    if (index == 0 || index >= QUICK_MESHES) {
        return index == 0;
    }
    ss_case_load_body(c, mesh, -1, on_surface, &body, &ignored);
    const bool is_small = body.mesh == NULL || body.mesh->node_count <= QUICK_NODES;
    ss_case_body_fini(&body);
    return is_small;
}

static softsim_status add_jobs(ss_accuracy *r, int32_t k, const char *name, softsim_error *error)
{
    const ss_case *c = &r->plan.c[k];
    const ss_model_class *model = ss_accuracy_model_find(name);
    const bool on_surface = model != NULL && model->hints->on_surface;
    int32_t mesh_count = 0;
    const ss_case_mesh *mesh = ss_case_meshes(c, on_surface, &mesh_count);
    ss_accuracy_plan *plan = c->is_dynamic ? &r->dynamic : &r->plan;
    softsim_status status = SOFTSIM_OK;
    for (int32_t i = 0; i < mesh_count && status == SOFTSIM_OK; ++i) {
        if (!ss_accuracy_is_listed(r->o.mesh, mesh[i].name) ||
            !ss_case_has_body(&mesh[i], on_surface) ||
            (r->o.mesh == NULL && r->o.is_quick && !is_quick_mesh(c, &mesh[i], i, on_surface))) {
            continue;
        }
        for (int32_t m = c->is_dynamic ? -1 : 0; m < c->material_count && status == SOFTSIM_OK;
             ++m) {
            if (c->is_dynamic || mesh[i].reference[m][0] != '\0') {
                const ss_accuracy_job job = {
                    .case_index = k, .material = m, .mesh = i, .model = name};
                status = add_job(plan, job, error);
            }
        }
    }
    return status;
}

static bool has_mesh(const ss_accuracy *r, const char *name)
{
    for (int32_t k = 0; k < r->plan.case_count; ++k) {
        for (int on_surface = 0; on_surface < 2; ++on_surface) {
            int32_t count = 0;
            const ss_case_mesh *mesh = ss_case_meshes(&r->plan.c[k], on_surface == 1, &count);
            for (int32_t i = 0; i < count; ++i) {
                if (strcmp(mesh[i].name, name) == 0) {
                    return true;
                }
            }
        }
    }
    return false;
}

static void check_meshes(const ss_accuracy *r, softsim_error *error)
{
    for (const char *at = r->o.mesh; at != NULL;) {
        char name[64];
        const size_t length = strcspn(at, ",");
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        if (!has_mesh(r, name)) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--mesh: no case has a mesh '%s'",
                              name);
        }
        at = at[length] == ',' ? at + length + 1 : NULL;
    }
}

static softsim_status list_jobs(ss_accuracy *r, softsim_error *error)
{
    int32_t count = 0;
    const ss_model_class *const *table = ss_model_table(&count);
    softsim_status status = SOFTSIM_OK;
    r->plan.folder = r->o.out;
    r->plan.is_quick = r->o.is_quick;
    r->plan.set = &r->o.set;
    r->plan.longest_cpu_s = r->o.is_quick ? quick_cpu_s : full_cpu_s;
    r->dynamic = r->plan;
    for (int32_t k = 0; k < r->plan.case_count; ++k) {
        for (int32_t i = 0; i < count && status == SOFTSIM_OK; ++i) {
            if (ss_accuracy_is_listed(r->o.model, table[i]->name)) {
                status = add_jobs(r, k, table[i]->name, error);
            }
        }
    }
    if (status == SOFTSIM_OK && r->plan.job_count + r->dynamic.job_count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "nothing to run: no case has a mesh that --mesh and --model leave");
        return SOFTSIM_ERROR_ARGUMENT;
    }
    return status;
}

/* Files of others are read for the pictures, when the runs are over: their faults are told before.
 */
static void check_compared(const ss_accuracy_options *o, const ss_accuracy_plan *plan,
                           softsim_error *error)
{
    ss_accuracy_rows rows = {.row = NULL};
    const int32_t faults = error->fault_count;
    for (int32_t k = 0; k < o->compare.count; ++k) {
        ss_accuracy_rows_compare(&rows, o->compare.value[k], error);
    }
    if (error->fault_count == faults) {
        ss_accuracy_check_compared(plan, &rows, error);
    }
    ss_accuracy_rows_fini(&rows);
}

/* All that can be wrong with what the command names, before anything is written or run. */
static softsim_status prepare(ss_accuracy *r, softsim_error *error)
{
    if (r->o.scene != NULL) {
        ss_case *c = calloc(1, sizeof *c); /* its reference takes minutes: the rows come first */
        if (c == NULL) {
            return ss_memory_fault(error);
        }
        ss_accuracy_scene_outline(c);
        check_compared(&r->o, &(ss_accuracy_plan){.c = c, .case_count = 1}, error);
        free(c);
        if (error->fault_count > 0) {
            return error->status;
        }
    }
    softsim_status status = load_cases(r, error);
    const bool has_cases = status == SOFTSIM_OK;
    if (has_cases) {
        check_meshes(r, error);
        status = error->fault_count == 0 ? list_jobs(r, error) : error->status;
    }
    if (status == SOFTSIM_OK) {
        ss_accuracy_check_bodies(&r->plan, &r->dynamic, error);
    }
    if (has_cases) {
        check_compared(&r->o, &r->plan, error);
    }
    return error->fault_count > 0 ? error->status : SOFTSIM_OK;
}

/* What a job's result depends on beside the program. */
static void label(const void *context, int32_t index, char out[SS_SWEEP_NAME_SIZE])
{
    const ss_accuracy_plan *plan = context;
    char id[256];
    ss_accuracy_job_id(plan, index, id);
    snprintf(out, SS_SWEEP_NAME_SIZE, "%.200s%s %016" PRIx64, id, plan->is_quick ? " quick" : "",
             plan->digest[plan->job[index].case_index]);
}

/* Texts of all runs one after the other, to be freed; `lose` (may be NULL) writes for a lost one.
 */
static char *gather(const ss_accuracy_plan *plan, const ss_sweep_result *result,
                    void (*lose)(const ss_accuracy_plan *, int32_t, const char *, FILE *))
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    for (int32_t i = 0; i < result->count && file != NULL; ++i) {
        if (result->run[i].is_lost) {
            lose(plan, i, result->run[i].text, file);
        } else {
            fputs(result->run[i].text, file);
        }
    }
    if (file == NULL || fclose(file) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

static void lose_dynamic(const ss_accuracy_plan *plan, int32_t index, const char *reason, FILE *out)
{
    const ss_accuracy_job *job = &plan->job[index];
    const ss_model_class *model = ss_accuracy_model_find(job->model);
    int32_t count = 0;
    const ss_case_mesh *mesh = ss_case_meshes(&plan->c[job->case_index],
                                              model != NULL && model->hints->on_surface, &count);
    fprintf(out, "%s,%s,%s,,,,", plan->c[job->case_index].name, job->model, mesh[job->mesh].name);
    ss_csv_text(out, reason);
    fputc('\n', out);
}

/* False in *out_is_complete: another rank writes the report. */
static softsim_status run_sweep(ss_accuracy *r, const ss_accuracy_plan *plan, bool *out_is_complete,
                                ss_sweep *sweep, ss_sweep_result *result, softsim_error *error)
{
    const bool is_dynamic = plan == &r->dynamic;
    char scratch[SS_ACCURACY_SCRATCH];
    *sweep = (ss_sweep){.folder = r->o.out,
                        .name = is_dynamic ? "dynamics" : "accuracy",
                        .count = plan->job_count,
                        .jobs = (int32_t)r->o.jobs,
                        .timeout_s = 40.0 * plan->longest_cpu_s, /* of a busy machine's clock */
                        .context = plan,
                        .label = label,
                        .run = is_dynamic ? ss_accuracy_run_dynamic : ss_accuracy_run_job};
    *result = (ss_sweep_result){.is_complete = true};
    const softsim_status status =
        plan->job_count > 0 ? ss_sweep_execute(sweep, result, error) : SOFTSIM_OK;
    *out_is_complete = result->is_complete;
    ss_accuracy_scratch_name(getpid(), scratch);
    ss_scratch_remove_all(scratch);
    return status;
}

/* ---- all ---- */

static softsim_status make_folders(const ss_accuracy *r, softsim_error *error)
{
    static const char *const parts[] = {"", "/fields", "/scenes"};
    softsim_status status = SOFTSIM_OK;
    for (size_t k = 0; k < sizeof parts / sizeof *parts && status == SOFTSIM_OK; ++k) {
        char path[SS_ACCURACY_PATH + 16];
        snprintf(path, sizeof path, "%s%s", r->o.out, parts[k]);
        status = ss_report_make_folder(path, error);
    }
    return status;
}

static softsim_status write_all(ss_accuracy *r, softsim_error *error)
{
    const int32_t own_count = r->rows.count;
    softsim_status status = ss_accuracy_rows_write(&r->rows, r->o.out, error);
    if (status == SOFTSIM_OK && r->dynamic.job_count > 0) {
        status = ss_accuracy_write_dynamics(r, error);
    }
    for (int32_t k = 0; k < r->o.compare.count && status == SOFTSIM_OK; ++k) {
        status = ss_accuracy_rows_compare(&r->rows, r->o.compare.value[k], error);
    }
    if (status == SOFTSIM_OK) {
        ss_yardstick_measure(&r->yardstick);
        status = ss_accuracy_write_page(r, error);
    }
    if (status == SOFTSIM_OK) {
        printf("%d rows in %s/accuracy.csv; %s/accuracy.html\n", own_count, r->o.out, r->o.out);
    }
    return status;
}

static softsim_status make_report(ss_accuracy *r, softsim_error *error)
{
    ss_sweep sweep[2];
    ss_sweep_result result[2] = {{.count = 0}, {.count = 0}};
    const ss_accuracy_plan *plan[2] = {&r->plan, &r->dynamic};
    bool is_complete = true;
    softsim_status status = make_folders(r, error);
    for (int k = 0; k < 2 && status == SOFTSIM_OK; ++k) {
        bool is_mine = true;
        status = run_sweep(r, plan[k], &is_mine, &sweep[k], &result[k], error);
        is_complete = is_complete && is_mine;
    }
    if (status == SOFTSIM_OK && is_complete) {
        char *jobs = gather(&r->plan, &result[0], ss_accuracy_lose_job);
        r->dynamics = gather(&r->dynamic, &result[1], lose_dynamic);
        if (jobs == NULL || r->dynamics == NULL) {
            free(jobs);
            status = ss_memory_fault(error);
        } else {
            status = ss_accuracy_rows_add(&r->rows, jobs, error);
        }
        status = status == SOFTSIM_OK ? write_all(r, error) : status;
    }
    for (int k = 0; k < 2; ++k) {
        if (status == SOFTSIM_OK && is_complete && plan[k]->job_count > 0) {
            ss_sweep_forget(&sweep[k], &result[k]);
        }
        ss_sweep_result_fini(&result[k]);
    }
    return status;
}

static void fini(ss_accuracy *r)
{
    for (int32_t k = 0; k < r->plan.case_count; ++k) {
        ss_case_fini(&r->plan.c[k]);
    }
    SS_EACH(free, r->plan.c, r->plan.job, r->dynamic.job, r->dynamics);
    ss_accuracy_rows_fini(&r->rows);
    free(r);
}

static int run_report(int argc, char **argv)
{
    softsim_error error = {.status = SOFTSIM_OK};
    ss_accuracy *r = calloc(1, sizeof *r);
    if (r == NULL) {
        return EXIT_FAILURE;
    }
    const ss_args_result parsed = parse(argc, argv, &r->o, &error);
    if (parsed == SS_ARGS_RUN) {
        check_models(&r->o, &error);
        check_sets(&r->o, &error);
        ss_process_catch_stop();
    }
    int exit_status = parsed == SS_ARGS_DONE ? EXIT_SUCCESS : SS_EXIT_BAD_INPUT;
    if (parsed == SS_ARGS_RUN && error.fault_count == 0 && prepare(r, &error) == SOFTSIM_OK) {
        exit_status = make_report(r, &error) == SOFTSIM_OK ? EXIT_SUCCESS : EXIT_FAILURE;
    }
    if (error.fault_count > 0) {
        ss_args_print_error(argv[0], &error);
    }
    if (exit_status == SS_EXIT_BAD_INPUT && error.status != SOFTSIM_ERROR_ARGUMENT) {
        softsim_error advice = {.status = SOFTSIM_OK};
        softsim_error_add(&advice, error.status,
                          "nothing was run: mend what is named, or leave it out of --case, --mesh "
                          "or --compare");
        ss_args_print_error(argv[0], &advice);
    }
    fini(r);
    return exit_status;
}

const ss_report_class ss_report_accuracy = {
    .name = "accuracy",
    .about = "error against run time of every model, on problems with trusted solutions",
    .run = run_report};
