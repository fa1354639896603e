/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Zhang, Zhong, Smith, Gu: "ChainMail based neural dynamics modeling of soft tissue deformation for
 * surgical simulation", Technology and Health Care 26, 2018: the sections of the report, in order.
 */
#include "bench/papers/zhang2018/zhang2018.h"

static const ss_paper_section sections[] = {
    {"Fig. 4: a plane, beside ChainMail", ss_zhang_shapes, 0.5},
    {"Fig. 5a: force and displacement", ss_zhang_forces, 1.5},
    {"Fig. 5b: hysteresis", ss_zhang_hysteresis, 0.7},
    {"Fig. 5c: stress relaxation", ss_zhang_relaxation, 0.3},
    {"Fig. 6: a liver under a probe, beside ChainMail", ss_zhang_liver, 8},
    {"Two tissues", ss_zhang_tissue, 0.2},
    {"Future work: many chain elements in a cell", ss_zhang_cells, 1},
    {"Future work: parameters by optimisation", ss_zhang_fitting, 1},
    {"Speed", ss_zhang_speed, 8},
};
enum { SECTION_COUNT = sizeof sections / sizeof sections[0] };

static void write_head(ss_page *page)
{
    ss_page_text(page,
                 "The paper makes ChainMail the connectivity of a cellular neural network: a link "
                 "that is longer or shorter than a band around its rest length pulls its two cells "
                 "towards that band, at a rate, instead of moving them there at once. Its figures "
                 "have no numbers on their scales; it does not say what the force at the contact "
                 "is, how alpha follows from the stiffness, how fast links are restored in "
                 "unloading, or what the state is saturated about.");
    ss_page_text(
        page, "This page repeats every figure with this program's own models, cnn-chainmail and "
              "chainmail, and judges the claims one by one. What is expected comes from the "
              "paper's own words and figures, from a closed form, or from an independent "
              "program: the same equations once more in double precision, sharing no code with "
              "the models (reference network), and linear finite elements. Where the paper gives a "
              "direction and no number, the least amount that counts is this report's. Pass: as "
              "claimed. Fail: not so. Differs: the paper's words hold in no reading that was "
              "searched; the search stands in the closing note. Lengths of the plane are in "
              "spacings h, times in capacitances C.");
    ss_page_text(page,
                 "Where the nonlinearity comes from: a link pulls in proportion to its length "
                 "beyond a dead band, so that the nonlinearity is the band's and the geometry's "
                 "(links turn as they are pulled, and slack ones join); the cells are linear, and "
                 "their bound K, where it is set, softens. Left out: cutting and tearing; links "
                 "never break.");
}

static void write_declined(ss_page *page)
{
    ss_page_heading(page, "Left out, and why");
    ss_page_text(page, "Neighbourhoods wider than r = 1: the paper sets r = 1, and a chain has no "
                       "links beyond its next neighbours that a wider one could use.");
    ss_page_text(page, "The control template B: the paper drops the cells' inputs, equation (4), "
                       "and with them what B would weigh.");
}

softsim_status ss_paper_zhang(ss_paper *paper, softsim_error *error)
{
    static ss_zhang zhang; /* large */
    zhang.paper = paper;
    zhang.has_network = ss_zhang_has("cnn-chainmail");
    paper->shared = &zhang;
    write_head(&paper->page);
    softsim_status status = ss_zhang_plane_init(&zhang.plane, error);
    if (!zhang.has_network) {
        ss_paper_miss(paper, "the model is not built into this program", "cnn-chainmail");
    } else if (status == SOFTSIM_OK) {
        status = ss_paper_run_sections(paper, SECTION_COUNT, sections, error);
    }
    ss_paper_write_missing(paper);
    write_declined(&paper->page);
    ss_paper_write_verdict(paper);
    ss_zhang_plane_fini(&zhang.plane);
    return status;
}
