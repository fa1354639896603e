/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Zhong, Shirinzadeh, Alici, Smith: "Haptic deformation modelling through cellular neural
 * network", I. J. of Simulation 7 (8), 2006: the sections of the report, in order.
 */
#include "bench/papers/zhong2006/zhong2006.h"

static const ss_paper_section sections[] = {
    {"Fig. 4: creep", ss_zhong_creep, 4},
    {"Fig. 5: hysteresis", ss_zhong_hysteresis, 4},
    {"Fig. 6: load and deformation", ss_zhong_load_curves, 8},
    {"Figs. 7 to 11: materials, local and large-range deformation", ss_zhong_materials, 10},
    {"Figs. 12 and 13: a kidney under a probe", ss_zhong_kidney, 8},
    {"Table 1: rates", ss_zhong_rates, 6},
    {"Equations 14 to 18, 26: templates and forces", ss_zhong_templates, 6},
    {"Equations 1, 2, 19: the network as a circuit", ss_zhong_relaxation, 6},
    {"Equations 3, 4, 26 and 28 as printed", ss_zhong_literal, 6},
    {"Equations 5 to 9 as printed", ss_zhong_density, 12},
    {"Closed organs", ss_zhong_organs, 10},
    {"Conclusion: a volume", ss_zhong_volume, 3},
    {"What must not change", ss_zhong_invariants, 3},
};
enum { SECTION_COUNT = sizeof sections / sizeof sections[0] };

static void write_head(ss_page *page)
{
    ss_page_text(page,
                 "The paper treats the surface of a soft body as a cellular neural network: what a "
                 "contact puts into the body is a current source on the contact's cell, the "
                 "network spreads it as the Poisson equation does, and the flux between two cells "
                 "becomes a force between two points. Its figures' axes have no numbers that could "
                 "be read off, and its equations leave open what acts after "
                 "unloading, whether the body remembers its rest, and whose lengths count.");
    ss_page_text(page,
                 "This page repeats every figure and table with this program's own model, "
                 "cnn-energy, run by itself without a server, and judges the claims one by one. "
                 "What is expected comes from the paper's own words and figures, from a closed "
                 "form, or from an independent program: a second implementation of the same "
                 "closure in double precision with dense algebra that shares no code with the "
                 "model (called reference network here). Where the paper gives a direction and no "
                 "number, the least amount that counts is this report's. Pass: as claimed. Fail: "
                 "not so. Differs: the paper's words hold in no well-posed reading that was "
                 "searched; the search stands in the closing note.");
    ss_page_text(page,
                 "Where the nonlinearity comes from: the tension of an edge follows its Green "
                 "strain, so bodies harden as they stretch; the network of cells itself is linear "
                 "until a cell reaches its bound K, which softens. Left out: cutting and tearing, "
                 "which the paper names as future work.");
    ss_page_text(page,
                 "The body of the first sections is the paper's cylinder: 360 points, 15 rings of "
                 "24, radius 1, length 4, both end rings fixed, its top point pushed down; mass 1, "
                 "damping as given, rest stiffness 0.1 a point, modulus 60, constitutive "
                 "coefficient 0.05. It is run as the paper's rectangular grid and as triangles "
                 "with alternating diagonals.");
}

static void write_declined(ss_page *page)
{
    ss_page_heading(page, "Left out, and why");
    ss_page_text(page, "Neighbourhoods wider than r = 1: the paper sets them aside for convenience "
                       "and gives no templates for them.");
    ss_page_text(page, "The control template B and inputs: the paper sets both to zero.");
    ss_page_text(page,
                 "The sources (3), (4) and the tensor form of (5) to (9) in the program. With rest "
                 "springs, which are not the paper's, both have readings that return to rest, "
                 "shown above with the map of where. (3), (4) hold no modulus, so that a deep dent "
                 "is the mesh's and not the tissue's; (5) to (9) have no potential, so that a hand "
                 "that goes round in a closed path takes energy out of the body.");
    ss_page_text(page, "Cutting and tearing, future work of the paper's: the links of the network "
                       "are fixed.");
    ss_page_text(page, "Adaptive remeshing: the paper names it as a possible speed-up; computing "
                       "only where the body moves serves the same purpose without changing the "
                       "mesh under the hand.");
    ss_page_text(page,
                 "The network as an analogue chip: out of a program's reach; the time that one "
                 "would settle in is given with the network as a circuit.");
    ss_page_text(page, "The PHANToM of Fig. 12: a recorded path stands for it; softsim-bridge "
                       "connects devices.");
}

static softsim_status make_tubes(ss_zhong *zhong, softsim_error *error)
{
    for (int k = 0; k < 2; ++k) {
        ss_tube *tube = &zhong->tube[k];
        const softsim_status status = ss_tube_init(zhong->paper, k == 0, false, tube, error);
        if (status != SOFTSIM_OK) {
            return status;
        }
        if (!tube->is_there) {
            ss_paper_miss(zhong->paper, tube->reason, "the cylinder as %s: every claim about it",
                          k == 0 ? "a rectangular grid" : "triangles");
        }
    }
    return SOFTSIM_OK;
}

softsim_status ss_paper_zhong(ss_paper *paper, softsim_error *error)
{
    static ss_zhong zhong; /* large */
    zhong.paper = paper;
    paper->shared = &zhong;
    write_head(&paper->page);
    softsim_status status = make_tubes(&zhong, error);
    if (status == SOFTSIM_OK) {
        status = ss_paper_run_sections(paper, SECTION_COUNT, sections, error);
    }
    ss_paper_write_missing(paper);
    write_declined(&paper->page);
    ss_paper_write_verdict(paper);
    for (int k = 0; k < 2; ++k) {
        ss_tube_fini(&zhong.tube[k]);
    }
    return status;
}
