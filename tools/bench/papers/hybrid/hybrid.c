/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The hybrid deformable model for haptic interactions (finite elements under a mesh-free layer):
 * the sections of the report, in order.
 */
#include "bench/papers/hybrid/hybrid.h"

static const ss_paper_section sections[] = {
    {"Fig. 2: the pair curve", ss_heart_pair_curve, 1},
    {"Table 1 and eq. 14: steps", ss_heart_steps, 8},
    {"Frames a second", ss_heart_rates, 6},
    {"Tetrahedra a second", ss_heart_speed, 15},
    {"Hybrid beside finite elements", ss_heart_indentation, 12},
    {"A thin wall, and what waking is felt as", ss_heart_walls, 40},
    {"Figs. 3 and 4: ventricles", ss_heart_pictures, 5},
    {"Equations 7, 8, 11, 13", ss_heart_literal, 5},
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
    ss_page_text(page,
                 "This page runs the paper's three models with this program's own fem and "
                 "hybrid, in the paper's units, and judges what the paper says. What is "
                 "expected comes from the paper's own words and figures, from a closed form, "
                 "or from an independent program: the same finite elements once more in "
                 "double precision, sharing no code with the models (reference elements). Pass: as "
                 "claimed. Fail: not so. Differs: the paper's words hold in no reading that "
                 "was searched; the search stands in the closing note. Times are thread-CPU "
                 "medians of this machine as loaded as it was; what one core could do in the "
                 "same run is at the end. The paper gives no units: its numbers are taken as "
                 "metres, pascals and seconds, density 1.");
    ss_page_text(page, "Where the nonlinearity comes from: Green strain, which is quadratic in the "
                       "displacement, under a linear law, and contact; below 0.65 of its volume "
                       "this program's guard stiffens an element. Left out: cutting and tearing; "
                       "no element is ever taken away.");
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
    write_head(&paper->page);
    const softsim_status status = ss_paper_run_sections(paper, SECTION_COUNT, sections, error);
    write_declined(&paper->page);
    ss_paper_write_verdict(paper);
    return status;
}
