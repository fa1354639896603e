/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What an element and sub-step take, integration included, at the sizes of the accuracy report's
 * meshes of 1k and 5k nodes, beside the flops and bytes that the model states. Shares of the
 * yardstick of the same run, which is the best of its passes, are of the best round.
 */
#include <math.h>
#include <stdio.h>

#include "bench/core/report.h"
#include "bench/scaling/scaling.h"
#include "models/model.h"

static const ss_element_speed_case cases[SS_SCALING_ELEMENT_CASES] = {
    {.model = "fem", .law = SS_TISSUE_STVK_GUARDED, .elements = 4349, .rounds = 41},
    {.model = "fem", .law = SS_TISSUE_STVK_GUARDED, .elements = 23727, .rounds = 15},
    {.model = "fem-quadratic", .law = SS_TISSUE_STABLE_NEO_HOOKEAN, .elements = 4349, .rounds = 41},
    {.model = "fem-quadratic",
     .law = SS_TISSUE_STABLE_NEO_HOOKEAN,
     .elements = 23727,
     .rounds = 15},
    {.model = "fem-quadratic",
     .law = SS_TISSUE_STABLE_NEO_HOOKEAN,
     .elements = 4349,
     .rounds = 41,
     .is_viscous = true},
    {.model = "fem-quadratic",
     .law = SS_TISSUE_STABLE_NEO_HOOKEAN,
     .elements = 23727,
     .rounds = 15,
     .is_viscous = true},
};

enum { ELEMENTS_A_NODE = 5 }; /* or more, in a volume */

softsim_status ss_scaling_measure_elements(ss_scaling *r, softsim_error *error)
{
    const int32_t most = r->options->block[r->options->block_count - 1] * ELEMENTS_A_NODE;
    softsim_status status = SOFTSIM_OK;
    for (int k = 0; k < SS_SCALING_ELEMENT_CASES && status == SOFTSIM_OK; ++k) {
        if (cases[k].elements <= most && ss_model_find(cases[k].model) != NULL) {
            r->element_case[r->element_count] = &cases[k];
            status = ss_element_speed_measure(&cases[k], &r->yardstick,
                                              &r->element[r->element_count++], error);
        }
    }
    return status;
}

/* A share of the median round as one of the best. */
static double best(const ss_element_speed *speed, double share)
{
    return share * speed->ns / speed->least_ns;
}

static const char *stress_of(const ss_element_speed_case *what)
{
    return what->is_viscous ? "viscous" : "elastic";
}

void ss_scaling_print_elements(const ss_scaling *r)
{
    printf("\nFMA peak %.1f GFLOP/s, in AVX-512 %.1f, memory %.1f GB/s\n", r->yardstick.fma_gflops,
           r->yardstick.fma_512_gflops, r->yardstick.bandwidth_gb_s);
    printf("%-14s %8s %8s %11s %8s %6s %6s %11s %11s %11s  %s\n", "elements of", "stress", "count",
           "ns sub-step", "ns best", "flops", "bytes", "% of peak", "% of 512's", "% of memory",
           "verdict");
    for (int32_t k = 0; k < r->element_count; ++k) {
        const ss_element_speed *at = &r->element[k];
        printf("%-14s %8s %8d %11.2f %8.2f %6.0f %6.0f %11.1f %11.1f %11.1f  %s\n",
               r->element_case[k]->model, stress_of(r->element_case[k]), at->elements, at->ns,
               at->least_ns, at->flops, at->bytes, 100.0 * best(at, at->flop_share),
               100.0 * best(at, at->flop_512_share), 100.0 * best(at, at->bandwidth_share),
               at->verdict);
    }
}

void ss_scaling_put_elements(ss_page *page, const ss_scaling *r)
{
    static const char *const head[] = {"model",
                                       "stress",
                                       "elements",
                                       "ns an element and sub-step",
                                       "of the best round",
                                       "flops",
                                       "bytes",
                                       "of the multiply-adds",
                                       "of those of AVX-512",
                                       "of the bandwidth",
                                       "verdict"};
    ss_page_table_begin(page, (int32_t)(sizeof head / sizeof *head), head);
    for (int32_t k = 0; k < r->element_count; ++k) {
        const ss_element_speed *at = &r->element[k];
        ss_row cells = {.count = 0};
        ss_row_add(&cells, "%s", r->element_case[k]->model);
        ss_row_add(&cells, "%s", stress_of(r->element_case[k]));
        ss_row_add(&cells, "%d", at->elements);
        ss_row_add_number(&cells, at->ns);
        ss_row_add_number(&cells, at->least_ns);
        ss_row_add_number(&cells, at->flops);
        ss_row_add_number(&cells, at->bytes);
        ss_row_add_number(&cells, best(at, at->flop_share));
        ss_row_add_number(&cells, best(at, at->flop_512_share));
        ss_row_add_number(&cells, best(at, at->bandwidth_share));
        ss_row_add(&cells, "%s", at->verdict);
        ss_page_table_row(page, cells.count, cells.cell);
    }
    ss_page_table_end(page);
}

static void put_row(FILE *file, const void *context, int32_t k)
{
    const ss_scaling *r = context;
    const ss_element_speed *at = &r->element[k];
    fprintf(file, "%s,%d,%d,%.4g,%.4g,%.6g,%.6g,%.4g,", r->element_case[k]->model,
            r->element_case[k]->is_viscous, at->elements, at->ns, at->least_ns, at->flops,
            at->bytes, best(at, at->flop_share));
    if (!isnan(at->flop_512_share)) {
        fprintf(file, "%.4g", best(at, at->flop_512_share));
    }
    fprintf(file, ",%.4g\n", best(at, at->bandwidth_share));
}

softsim_status ss_scaling_write_elements(const ss_scaling *r, softsim_error *error)
{
    return ss_report_csv_write(r->options->out, "elements",
                               "model,is_viscous,elements,ns,least_ns,flops,bytes,flop_share,"
                               "flop_512_share,bandwidth_share",
                               r->element_count, put_row, r, error);
}
