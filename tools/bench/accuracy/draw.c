/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Pictures of the accuracy report. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/accuracy/accuracy.h"
#include "bench/core/surface_picture.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { MAX_SHAPE_NODES = 8000, NAME_SIZE = 300 };

typedef struct drawing {
    ss_page *page;
    const ss_accuracy_plan *plan;
    const ss_accuracy_rows *rows;
    const ss_case *c;
    int32_t material;
    ss_accuracy_means means;
    bool *is_drawn;                 /* of each mean: begins a series */
    const ss_accuracy_mean **shown; /* room for each mean */
    softsim_error *error;
} drawing;

/* ---- error against time ---- */

static double step_time(const ss_accuracy_mean *m)
{
    return 1e3 / m->realtime; /* us for a ms */
}

static double settling_time(const ss_accuracy_mean *m)
{
    return m->to_1pct_ms;
}

/* A name as gnuplot's strings take it. */
static void put_name(FILE *file, const char *text)
{
    for (; *text != '\0'; ++text) {
        fputc(strchr("'\"\\", *text) != NULL || (unsigned char)*text < ' ' ? ' ' : *text, file);
    }
}

/* The same in every picture; programs of others are black. */
static const char *colour_of(const ss_accuracy_row *row)
{
    const ss_model_class *model = ss_accuracy_model_find(row->model);
    return row->source == 0 && model != NULL ? model->hints->colour : "black";
}

static bool is_first_of_model(const drawing *d, int32_t k)
{
    for (int32_t i = 0; i < k; ++i) {
        if (d->means.mean[i].first->source == d->means.mean[k].first->source &&
            strcmp(d->means.mean[i].first->model, d->means.mean[k].first->model) == 0) {
            return false;
        }
    }
    return true;
}

/* Of all points: gnuplot's own would go to whole decades. */
typedef struct range {
    double low[2], high[2]; /* time, error */
} range;

static void widen(range *r, double time, double error)
{
    const double at[2] = {time, error};
    for (int k = 0; k < 2; ++k) {
        r->low[k] = fmin(r->low[k], at[k]);
        r->high[k] = fmax(r->high[k], at[k]);
    }
}

static int32_t put_series(FILE *file, const drawing *d, int32_t of,
                          double (*time)(const ss_accuracy_mean *), range *r)
{
    int32_t points = 0;
    fprintf(file, "$series%d << EOD\n", of);
    for (int32_t k = of; k < d->means.count; ++k) {
        const ss_accuracy_mean *m = &d->means.mean[k];
        if (m->first->source == d->means.mean[of].first->source &&
            strcmp(m->first->model, d->means.mean[of].first->model) == 0 && m->error_l2 > 0.0 &&
            time(m) > 0.0) {
            widen(r, time(m), m->error_l2);
            fprintf(file, "%.6g %.6g \"", time(m), m->error_l2);
            put_name(file, m->first->mesh);
            fputs("\"\n", file);
            ++points;
        }
    }
    fputs("EOD\n", file);
    return points;
}

/* The front, from fast to slow. */
static int32_t put_front(FILE *file, const drawing *d, double (*time)(const ss_accuracy_mean *))
{
    const ss_accuracy_means *all = &d->means;
    int32_t count = 0;
    for (int32_t k = 0; k < all->count; ++k) {
        const ss_accuracy_mean *m = &all->mean[k];
        all->time[k] = time(m) > 0.0 ? time(m) : (double)NAN;
        all->error[k] = m->error_l2 > 0.0 && !m->is_other ? m->error_l2 : (double)NAN;
    }
    ss_accuracy_pareto(all->count, all->time, all->error, all->is_front);
    fputs("$front << EOD\n", file);
    for (;;) {
        int32_t next = -1;
        for (int32_t k = 0; k < all->count; ++k) {
            next = all->is_front[k] && (next < 0 || all->time[k] < all->time[next]) ? k : next;
        }
        if (next < 0) {
            break;
        }
        fprintf(file, "%.6g %.6g\n", all->time[next], all->error[next]);
        all->is_front[next] = false;
        ++count;
    }
    fputs("EOD\n", file);
    return count;
}

static softsim_status draw_times(drawing *d, const char *kind, const char *label,
                                 const char *caption, double (*time)(const ss_accuracy_mean *))
{
    char name[NAME_SIZE], text[400];
    ss_output script;
    range r = {.low = {(double)INFINITY, (double)INFINITY}};
    snprintf(name, sizeof name, "%s_%s_%s", kind, d->c->name, d->c->material[d->material]);
    const softsim_status status = ss_plot_open(&script, d->plan->folder, name, d->error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    for (int32_t k = 0; k < d->means.count; ++k) {
        d->is_drawn[k] = is_first_of_model(d, k) && put_series(file, d, k, time, &r) > 0;
    }
    if (put_front(file, d, time) == 0) {
        ss_output_abandon(&script);
        return SOFTSIM_OK;
    }
    fprintf(file,
            "set logscale xy\nset grid\nset key outside right\nset xrange [%.3g:%.3g]\nset yrange "
            "[%.3g:%.3g]\nset xlabel '%s'\nset ylabel 'error of the field, mean of the levels'\n"
            "plot ",
            r.low[0] / 1.6, r.high[0] * 2.2, r.low[1] / 1.5, r.high[1] * 1.5, label);
    for (int32_t k = 0; k < d->means.count; ++k) {
        const ss_accuracy_row *row = d->means.mean[k].first;
        if (!d->is_drawn[k]) {
            continue;
        }
        fprintf(file, "$series%d using 1:2 with linespoints lw 1.5 pt %d lc rgb '%s' title '", k,
                row->source == 0 ? 7 : 4, colour_of(row));
        put_name(file, row->model);
        fputs(row->source == 0 ? "', " : " *', ", file);
        fprintf(file,
                "$series%d using 1:2:3 with labels left offset 0.7,0.4 font ',9' tc rgb "
                "'%s' notitle, ",
                k, colour_of(row));
    }
    fputs("$front using 1:2 with linespoints lw 1 dt 2 pt 6 ps 2 lc rgb 'black' title 'Pareto "
          "front'\n",
          file);
    snprintf(text, sizeof text, "%s, %s: %s%s", d->c->name, d->c->material[d->material], caption,
             d->rows->source_count > 0 ? " *: from --compare." : "");
    return ss_page_plot(d->page, &script, name, text, d->error);
}

/* ---- force against depth ---- */

/* The finest mesh on which the model has a force at every level, else any. */
static const ss_accuracy_mean *finest(const drawing *d, const char *model)
{
    const ss_accuracy_mean *best = NULL;
    for (int32_t k = 0; k < d->means.count; ++k) {
        const ss_accuracy_mean *m = &d->means.mean[k];
        if (m->first->source == 0 && strcmp(m->first->model, model) == 0 &&
            !isnan(m->error_force) && (best == NULL || m->first->nodes > best->first->nodes)) {
            best = m;
        }
    }
    return best;
}

static void put_force_block(FILE *file, const drawing *d, int32_t number, const char *model,
                            const char *mesh)
{
    fprintf(file, "$force%d << EOD\n0 0\n", number);
    for (int32_t i = 0; i < d->rows->count; ++i) {
        const ss_accuracy_row *row = &d->rows->row[i];
        if (row->source == 0 && strcmp(row->case_name, d->c->name) == 0 &&
            strcmp(row->material, d->c->material[d->material]) == 0 &&
            strcmp(row->model, model) == 0 && strcmp(row->mesh, mesh) == 0 && !isnan(row->force)) {
            fprintf(file, "%.6g %.6g\n", 1e3 * row->value, row->force);
        }
    }
    fputs("EOD\n", file);
}

static softsim_status draw_forces(drawing *d)
{
    char name[NAME_SIZE], text[200];
    ss_output script;
    int32_t count = 0, known = 0;
    for (int32_t k = 0; k < d->c->level_count; ++k) {
        known += d->c->level[k].material == d->material && !isnan(d->c->level[k].force);
    }
    for (int32_t k = 0; k < d->means.count && known > 0; ++k) {
        const ss_accuracy_mean *m =
            is_first_of_model(d, k) ? finest(d, d->means.mean[k].first->model) : NULL;
        if (m != NULL && d->means.mean[k].first->source == 0) {
            d->shown[count++] = m;
        }
    }
    if (count == 0) {
        return SOFTSIM_OK;
    }
    snprintf(name, sizeof name, "force_%s_%s", d->c->name, d->c->material[d->material]);
    const softsim_status status = ss_plot_open(&script, d->plan->folder, name, d->error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    fputs("$reference << EOD\n0 0\n", file);
    for (int32_t k = 0; k < d->c->level_count; ++k) {
        const ss_case_level *level = &d->c->level[k];
        if (level->material == d->material && !isnan(level->force)) {
            fprintf(file, "%.6g %.6g\n", 1e3 * level->value, level->force);
        }
    }
    fputs("EOD\n", file);
    for (int32_t k = 0; k < count; ++k) {
        put_force_block(file, d, k, d->shown[k]->first->model, d->shown[k]->first->mesh);
    }
    fputs(
        "set grid\nset key left top\nset xlabel 'push, mm'\nset ylabel 'force along the push, N'\n"
        "plot $reference with linespoints lw 3 pt 6 lc rgb 'black' title 'reference'",
        file);
    for (int32_t k = 0; k < count; ++k) {
        fprintf(file, ", $force%d with linespoints lw 1.5 pt 7 ps 0.7 lc rgb '%s' title '", k,
                colour_of(d->shown[k]->first));
        put_name(file, d->shown[k]->first->model);
        fputs(", ", file);
        put_name(file, d->shown[k]->first->mesh);
        fputs(d->shown[k]->is_calibrated ? " (calibrated)'" : "'", file);
    }
    fputs("\n", file);
    snprintf(text, sizeof text, "%s, %s: force against depth, each model on its finest mesh.",
             d->c->name, d->c->material[d->material]);
    return ss_page_plot(d->page, &script, name, text, d->error);
}

/* ---- shapes ---- */

typedef struct pair {
    double (*rest)[3], (*u)[3]; /* the model's body, then the reference's */
    int32_t (*face)[4];
    uint32_t *colour;
    double *error; /* of a node, over the largest displacement */
    int32_t node_count, face_count;
    double worst;
} pair;

static void pair_fini(pair *p)
{
    SS_EACH(free, p->rest, p->u, p->face, p->colour, p->error);
}

/* Columns of fields/ID.csv into both halves. */
static bool read_field(drawing *d, const char *id, pair *p)
{
    static const char *const names[] = {"x", "y", "z", "ux", "uy", "uz", "rx", "ry", "rz"};
    char path[SS_ACCURACY_PATH + NAME_SIZE];
    ss_table table = {.path = NULL};
    softsim_error missing = {.status = SOFTSIM_OK}; /* a model that has no field has no picture */
    int32_t column[9];
    double peak = 0.0;
    snprintf(path, sizeof path, "%s/fields/%s.csv", d->plan->folder, id);
    bool is_good =
        ss_table_load(path, &table, &missing) == SOFTSIM_OK && table.row_count == p->node_count;
    for (int k = 0; k < 9 && is_good; ++k) {
        column[k] = ss_table_find(&table, names[k], &missing);
        is_good = column[k] >= 0;
    }
    for (int32_t i = 0; i < p->node_count && is_good; ++i) {
        double x[9], difference[3];
        for (int k = 0; k < 9; ++k) {
            x[k] = ss_table_number(&table, i, column[k], &missing);
        }
        ss_copy3(p->rest[i], x);
        ss_copy3(p->rest[p->node_count + i], x);
        ss_copy3(p->u[i], x + 3);
        ss_copy3(p->u[p->node_count + i], x + 6);
        ss_sub3(difference, x + 3, x + 6);
        p->error[i] = ss_norm3(difference);
        peak = fmax(peak, ss_norm3(x + 6));
        is_good = missing.fault_count == 0;
    }
    for (int32_t i = 0; i < p->node_count && is_good; ++i) {
        p->error[i] = peak > 0.0 ? p->error[i] / peak : 0.0;
        p->worst = fmax(p->worst, p->error[i]);
    }
    ss_table_fini(&table);
    return is_good;
}

static uint32_t blend(double share)
{
    static const int from[3] = {0xf4, 0xea, 0xdc}, to[3] = {0xb8, 0x10, 0x28};
    uint32_t out = 0;
    for (int k = 0; k < 3; ++k) {
        const double value = from[k] + fmin(share, 1.0) * (to[k] - from[k]);
        out = out << 8 | (uint32_t)value;
    }
    return out;
}

static void fill_faces(pair *p, const ss_mesh *mesh)
{
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        double error = 0.0;
        for (int k = 0; k < 3; ++k) {
            const int32_t node = mesh->triangle[t][k];
            p->face[t][k] = node;
            p->face[mesh->triangle_count + t][k] = p->node_count + node;
            error += p->error[node] / 3.0;
        }
        p->face[t][3] = p->face[mesh->triangle_count + t][3] = -1;
        p->colour[t] = blend(error / fmax(p->worst, 1e-9));
        p->colour[mesh->triangle_count + t] = 0xc8ccd4;
    }
}

/* Up is against the load; the body's longer side lies across. */
static void choose_view(const ss_case *c, const ss_mesh *mesh, ss_surface_picture_view *view)
{
    double low[3], high[3], up[3] = {0.0, 0.0, 1.0};
    if (c->pushed[0] != '\0') {
        ss_scale3(up, c->direction, -1.0);
    } else if (ss_norm3(c->gravity) > 0.0) {
        ss_scale3(up, c->gravity, -1.0);
    }
    ss_normalize3(up);
    ss_copy3(low, mesh->position[0]);
    ss_copy3(high, low);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            low[k] = fmin(low[k], mesh->position[i][k]);
            high[k] = fmax(high[k], mesh->position[i][k]);
        }
    }
    int upward = 0;
    for (int k = 1; k < 3; ++k) {
        upward = fabs(up[k]) > fabs(up[upward]) ? k : upward;
    }
    const int a = (upward + 1) % 3, b = (upward + 2) % 3;
    const int across = high[a] - low[a] >= high[b] - low[b] ? a : b, towards = across == a ? b : a;
    ss_scale3(view->eye, up, 0.45);
    view->eye[towards] -= 1.0;
    view->eye[across] += 0.3;
    ss_copy3(view->up, up);
}

/* The reference stands to the right of the model. */
static void set_apart(pair *p, const ss_surface_picture_view *view)
{
    double right[3], low = (double)INFINITY, high = -(double)INFINITY;
    ss_cross3(right, view->up, view->eye);
    ss_normalize3(right);
    for (int32_t i = 0; i < 2 * p->node_count; ++i) {
        double x[3];
        for (int pass = 0; pass < 2; ++pass) {
            ss_madd3(x, p->rest[i], pass, p->u[i]);
            low = fmin(low, ss_dot3(x, right));
            high = fmax(high, ss_dot3(x, right));
        }
    }
    for (int32_t i = p->node_count; i < 2 * p->node_count; ++i) {
        ss_madd3(p->rest[i], p->rest[i], 1.08 * (high - low), right);
    }
}

static softsim_status draw_pair(drawing *d, const char *id, const ss_accuracy_mean *m,
                                const ss_mesh *mesh, pair *p)
{
    char name[NAME_SIZE + 8], caption[400], label[160];
    ss_surface_picture_view view = {.label = label};
    const ss_accuracy_row *last = m->first;
    for (int32_t i = 0; i < d->rows->count; ++i) {
        const ss_accuracy_row *at = &d->rows->row[i];
        last = at->source == 0 && strcmp(at->case_name, last->case_name) == 0 &&
                       strcmp(at->material, last->material) == 0 &&
                       strcmp(at->model, last->model) == 0 && strcmp(at->mesh, last->mesh) == 0 &&
                       !isnan(at->error_l2)
                   ? at
                   : last;
    }
    choose_view(d->c, mesh, &view);
    fill_faces(p, mesh);
    set_apart(p, &view);
    snprintf(label, sizeof label, "%s, left, and reference", m->first->model);
    snprintf(name, sizeof name, "shape_%s", id);
    snprintf(caption, sizeof caption,
             "%s, %s, %s on mesh %s at %s: error of the field %.3g. Pale: none; deep red: %.3g of "
             "the largest displacement.",
             d->c->name, last->material, last->model, last->mesh, last->level, last->error_l2,
             p->worst);
    const ss_surface_picture shape = {.node_count = 2 * p->node_count,
                                      .face_count = 2 * mesh->triangle_count,
                                      .rest = (const double(*)[3])p->rest,
                                      .u = (const double(*)[3])p->u,
                                      .face = (const int32_t(*)[4])p->face,
                                      .colour = p->colour,
                                      .pushed = -1};
    return ss_surface_picture_put(d->page, name, caption, &shape, &view, 1, d->error);
}

/* The files of a mean's job. */
static const ss_accuracy_job *find_job(const drawing *d, const ss_accuracy_mean *m, char id[256])
{
    for (int32_t k = 0; k < d->plan->job_count; ++k) {
        const ss_accuracy_job *job = &d->plan->job[k];
        const ss_model_class *model = ss_accuracy_model_find(job->model);
        int32_t count = 0;
        const ss_case_mesh *mesh = ss_case_meshes(
            &d->plan->c[job->case_index], model != NULL && model->hints->on_surface, &count);
        if (&d->plan->c[job->case_index] == d->c && job->material == d->material &&
            strcmp(job->model, m->first->model) == 0 &&
            strcmp(mesh[job->mesh].name, m->first->mesh) == 0) {
            ss_accuracy_job_id(d->plan, k, id);
            return job;
        }
    }
    return NULL;
}

static softsim_status draw_shape(drawing *d, const ss_accuracy_mean *m)
{
    char id[256];
    const ss_accuracy_job *job = find_job(d, m, id);
    const ss_model_class *model = ss_accuracy_model_find(m->first->model);
    ss_case_body body = {.mesh = NULL};
    int32_t count = 0;
    softsim_status status = SOFTSIM_OK;
    if (job == NULL || model == NULL) {
        return SOFTSIM_OK;
    }
    const ss_case_mesh *mesh = &ss_case_meshes(d->c, model->hints->on_surface, &count)[job->mesh];
    status = ss_case_load_body(d->c, mesh, -1, model->hints->on_surface, &body, d->error);
    if (status == SOFTSIM_OK) {
        const size_t n = (size_t)body.mesh->node_count, t = (size_t)body.mesh->triangle_count;
        pair p = {.rest = calloc(2 * n, sizeof *p.rest),
                  .u = calloc(2 * n, sizeof *p.u),
                  .face = calloc(2 * t, sizeof *p.face),
                  .colour = calloc(2 * t, sizeof *p.colour),
                  .error = calloc(n, sizeof *p.error),
                  .node_count = body.mesh->node_count};
        if (p.rest && p.u && p.face && p.colour && p.error && read_field(d, id, &p)) {
            status = draw_pair(d, id, m, body.mesh, &p);
        }
        pair_fini(&p);
    }
    ss_case_body_fini(&body);
    return status;
}

/* Of each model its most accurate mesh that is not too large for a picture. */
static softsim_status draw_shapes(drawing *d)
{
    softsim_status status = SOFTSIM_OK;
    for (int32_t k = 0; k < d->means.count && status == SOFTSIM_OK; ++k) {
        const ss_accuracy_mean *best = NULL;
        if (d->means.mean[k].first->source != 0 || !is_first_of_model(d, k)) {
            continue;
        }
        for (int32_t i = k; i < d->means.count; ++i) {
            const ss_accuracy_mean *m = &d->means.mean[i];
            if (m->first->source == 0 &&
                strcmp(m->first->model, d->means.mean[k].first->model) == 0 &&
                m->first->nodes <= MAX_SHAPE_NODES && !isnan(m->error_l2) &&
                (best == NULL || m->error_l2 < best->error_l2)) {
                best = m;
            }
        }
        status = best != NULL ? draw_shape(d, best) : SOFTSIM_OK;
    }
    return status;
}

/* ---- all ---- */

static softsim_status draw_material(drawing *d, bool has_shapes)
{
    softsim_status status = draw_times(d, "error", "us of one core for 1 ms of time",
                                       "error against run time; each point is a mesh.", step_time);
    if (status == SOFTSIM_OK) {
        status = draw_times(d, "settle", "ms of one core until within 1 % of its own settled state",
                            "error against the time to settle, ramp of the load included.",
                            settling_time);
    }
    if (status == SOFTSIM_OK) {
        status = draw_forces(d);
    }
    return status == SOFTSIM_OK && has_shapes ? draw_shapes(d) : status;
}

softsim_status ss_accuracy_draw(ss_page *page, const ss_accuracy_plan *plan, const ss_case *c,
                                int32_t material, bool has_shapes, const ss_accuracy_rows *rows,
                                softsim_error *error)
{
    drawing d = {
        .page = page, .plan = plan, .rows = rows, .c = c, .material = material, .error = error};
    softsim_status status =
        ss_accuracy_means_find(rows, c->name, c->material[material], &d.means, error);
    d.is_drawn = calloc((size_t)d.means.count + 1, sizeof *d.is_drawn);
    d.shown = calloc((size_t)d.means.count + 1, sizeof *d.shown);
    if (status == SOFTSIM_OK && (d.is_drawn == NULL || d.shown == NULL)) {
        status = ss_memory_fault(error);
    }
    status = status == SOFTSIM_OK ? draw_material(&d, has_shapes) : status;
    free(d.is_drawn);
    free(d.shown);
    ss_accuracy_means_fini(&d.means);
    return status;
}
