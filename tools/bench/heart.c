/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The hybrid deformable model for haptic interactions (finite elements under a mesh-free layer):
 * the sections of the report, in order.
 */
#include "heart.h"

static const struct {
    const char *heading;
    softsim_status (*run)(ss_paper *paper, softsim_error *error);
    double weight; /* seconds, roughly */
} sections[] = {
    {"Fig. 2: the pair curve", ss_heart_pair_curve, 1},
    {"Table 1 and eq. 14: steps", ss_heart_steps, 8},
    {"Frames a second", ss_heart_rates, 6},
    {"Tetrahedra a second", ss_heart_speed, 15},
    {"Hybrid beside finite elements", ss_heart_indentation, 12},
    {"A thin wall, and what waking is felt as", ss_heart_walls, 40},
    {"Figs. 3 and 4: ventricles", ss_heart_pictures, 5},
    {"Equations 7, 8, 11, 13 as printed", ss_heart_literal, 2},
};
enum { SECTION_COUNT = sizeof sections / sizeof sections[0] };

static void write_head(ss_page *page)
{
    ss_page_text(page,
                 "The paper moves the bulk of a soft body by a coarse mesh of tetrahedra under "
                 "Green strain, and gives the place where a hand touches it detail by a layer of "
                 "particles that wake near the tool. Its equations leave out the Kronecker delta "
                 "of (2), the rest volume of (6) and any normalisation of (7), and add up both "
                 "interpolations where they overlap (11).");
    ss_page_text(page, "This page runs the paper's three models with this program's own fem and "
                       "hybrid, in the paper's units, and judges what the paper says and what the "
                       "closures promise. Pass: as claimed. Differs: the paper's words, taken "
                       "literally, do not hold; the reason is beside it. Times are thread-CPU "
                       "medians of this machine as loaded as it was; the yardstick below is of the "
                       "same run.");
}

static void write_declined(ss_page *page)
{
    ss_page_heading(page, "Left out, and why");
    ss_page_text(page,
                 "A Galerkin mesh-free layer, which the paper names as coming work: its moving "
                 "least squares make every quadrature point depend on about thirty particles, and "
                 "it needs about eight such points for each particle, where the layer here "
                 "integrates at the particles alone with a residual that takes the place of the "
                 "other seven: eight times the cost of a particle for the same rows.");
    ss_page_text(page, "The patient's SPECT data: the ventricles here are the ellipsoids that the "
                       "figures resemble. The haptic device: softsim-bridge connects one.");
}

softsim_status ss_paper_hybrid(ss_paper *paper, softsim_error *error)
{
    softsim_status status = SOFTSIM_OK;
    for (int k = 0; k < SECTION_COUNT; ++k) {
        paper->weight_all += sections[k].weight;
    }
    write_head(&paper->page);
    for (int k = 0; status == SOFTSIM_OK && k < SECTION_COUNT; ++k) {
        paper->section = sections[k].heading;
        paper->weight = sections[k].weight;
        ss_paper_progress(paper, 0.0);
        ss_page_heading(&paper->page, sections[k].heading);
        status = sections[k].run(paper, error);
        ss_paper_show_claims(paper);
        paper->weight_done += sections[k].weight;
    }
    write_declined(&paper->page);
    ss_page_heading(&paper->page, "Verdict");
    ss_page_text(&paper->page, "%d claims: %d pass, %d fail, %d differ from the paper's words.",
                 paper->claim_count, ss_paper_count(paper, SS_CLAIM_PASS),
                 ss_paper_count(paper, SS_CLAIM_FAIL), ss_paper_count(paper, SS_CLAIM_DIFFERS));
    ss_page_link(&paper->page, "claims.csv");
    return status;
}
