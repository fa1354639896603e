/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Are the bodies of the accuracy report whole? Every file that a job will read is read once before
 * the first job starts, one body at a time, and dropped: on the largest bundled mesh that is a
 * tenth of a second, where a damaged file found by its job costs the hours of those before it.
 * Rejected: keeping what was read for the jobs, which are processes of their own, perhaps on other
 * machines.
 */
#include <string.h>

#include "accuracy.h"

/* What a job reads: two with the same need it once. */
typedef struct need {
    int32_t case_index, material, mesh;
    bool on_surface;
} need;

static need need_of(const ss_accuracy_job *job)
{
    const ss_accuracy_model *model = ss_accuracy_model_find(job->model);
    return (need){.case_index = job->case_index,
                  .material = job->material,
                  .mesh = job->mesh,
                  .on_surface = model != NULL && model->on_surface};
}

/* Does an earlier job read the same? */
static bool is_known(const ss_accuracy_plan *plan, int32_t index)
{
    const need own = need_of(&plan->job[index]);
    for (int32_t k = 0; k < index; ++k) {
        const need other = need_of(&plan->job[k]);
        if (other.case_index == own.case_index && other.material == own.material &&
            other.mesh == own.mesh && other.on_surface == own.on_surface) {
            return true;
        }
    }
    return false;
}

/* Bodies share files: what one says of a file is not said again for the next. */
static void take_faults(const softsim_error *own, softsim_error *error)
{
    if (own->fault_count > 0 && strstr(error->text, own->text) == NULL) {
        softsim_error_add(error, own->status, "%s", own->text);
    }
}

static void check_plan(const ss_accuracy_plan *plan, softsim_error *error)
{
    for (int32_t k = 0; k < plan->job_count; ++k) {
        if (is_known(plan, k)) {
            continue;
        }
        const need own = need_of(&plan->job[k]);
        const ss_case *c = &plan->c[own.case_index];
        int32_t count = 0;
        ss_case_body body;
        softsim_error faults = {.status = SOFTSIM_OK};
        const ss_case_mesh *mesh = &ss_case_meshes(c, own.on_surface, &count)[own.mesh];
        ss_case_load_body(c, mesh, own.material, own.on_surface, &body, &faults);
        ss_case_body_fini(&body);
        take_faults(&faults, error);
    }
}

softsim_status ss_accuracy_check_bodies(const ss_accuracy_plan *plan,
                                        const ss_accuracy_plan *dynamic, softsim_error *error)
{
    const int32_t faults = error->fault_count;
    check_plan(plan, error);
    check_plan(dynamic, error);
    return error->fault_count > faults ? error->status : SOFTSIM_OK;
}
