/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * What a plan uses and leaves out.
 */
#include <math.h>

#include "rt/note.h"

static void explain_net(const ss_model *model, const ss_notes *out)
{
    const ss_chain_net *net = model->net;
    const ss_mesh *mesh = model->plan.mesh;
    ss_note_used(out, "chain",
                 "%d elements (%d fixed), %d links of %s, each once (%d of elements shared), mean "
                 "%.4g m, %.2f MB",
                 model->node_count, model->fixed_count, net->link_count,
                 mesh->tetrahedron_count > 0 ? "tetrahedra"
                 : mesh->quad_count > 0      ? "a rectangular grid"
                                             : "triangles",
                 net->duplicates, net->mean_length, (double)ss_chain_net_bytes(net) / 1048576.0);
    ss_note_used(out, "kernels", "%s, %s", model->kernels->name,
                 sizeof(ss_real) == sizeof(float) ? "single precision" : "double precision");
    if (ss_chain_is_aggregated(model)) {
        ss_note_used(out, "cells",
                     "the elements are aggregated into %d away from tools, which step every %.4g s",
                     ss_chain_coarse_cells(model->coarse), ss_chain_aggregated_step(model));
    } else if (model->coarse) {
        ss_note_used(out, "coarse level", "%d cells, %.2f MB", ss_chain_coarse_cells(model->coarse),
                     (double)ss_chain_coarse_bytes(model->coarse) / 1048576.0);
    } else {
        ss_note_left_out(out, "coarse level", NULL, "none asked for, or too few elements for one");
    }
    if (model->coarse || isfinite(model->saturation)) {
        ss_note_left_out(out, "active set", NULL, "%s touches every element",
                         ss_chain_is_aggregated(model) ? "an aggregated cell"
                         : model->coarse               ? "the coarse level"
                                                       : "saturation");
    } else {
        ss_note_used(out, "active set", "links that are slack and still are not looked at");
    }
    if (model->guard) {
        ss_note_used(out, "tet guard", "%d tetrahedra are kept above a fifth of their volume",
                     mesh->tetrahedron_count);
    } else {
        ss_note_left_out(out, "tet guard", NULL, "no tetrahedra, or tet_guard is 0");
    }
}

static void explain_material(const ss_model *model, const ss_notes *out)
{
    static const char *const unloading[] = {"falls with the contact's depth (ramp)",
                                            "is 0 once one goes back (literal)", "stays (keep)"};
    ss_note_used(out, "links", "k %.4g N/m, alpha %s; unloading: alpha %s", model->k,
                 model->has_alpha ? "as given" : "0", unloading[model->unloading]);
    if (model->leak > 0.0) {
        ss_note_used(out, "leak", "back to the rest shape in about %.3g s",
                     model->capacitance / model->leak);
    } else {
        ss_note_left_out(out, "leak", NULL, "what is slack stays where it was pushed");
    }
    if (!(model->leak > 0.0) && model->plan.mesh->tetrahedron_count == 0) {
        ss_note_used(out, "held press",
                     "its force fades (a surface of links has nothing inside and bends freely); "
                     "leak_resistance: 10 keeps most of it, less keeps more");
    }
    if (isfinite(model->saturation)) {
        ss_note_used(out, "saturation", "%.4g m", model->saturation);
    } else {
        ss_note_left_out(out, "saturation of cells", "model.saturation_sizes=1e6", "none given");
    }
    ss_note_used(out, "capacitance",
                 "%.4g s (%s); stable step %.4g s, %.0f sub-steps of a step of %.4g s",
                 model->capacitance, model->is_capacitance_given ? "given" : "chosen for the mesh",
                 ss_chain_stable_step(model),
                 ceil(model->plan.step / ss_chain_stable_step(model) - 1e-9), model->plan.step);
    if (model->tools.surface) {
        ss_tools_say_grasp(&model->plan, out);
    }
    ss_tools_warn_unheld(&model->tools, model->is_held, out);
    ss_tools_warn_rounded(&model->tools, &model->plan, out);
}

void ss_chain_explain(const ss_model *model, const ss_notes *out)
{
    explain_net(model, out);
    explain_material(model, out);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &model->tools.tool[k];
        if (tool->is_used) {
            ss_note_used(out, "contact.tools",
                         "tool %d: %s, contact %.4g N/m^3, %.4g N/m at first touch", k,
                         model->is_current ? "a current source" : "holds the cells it touches",
                         tool->stiffness, tool->rest_felt);
        }
    }
    if (model->is_current && model->plan.contact_stiffness > 0.0) {
        ss_note_warning(out, "contact.stiffness_n_per_m3",
                        "not used: with source: current the contact stiffness follows from "
                        "link_stiffness_n_per_m and the area of a cell; give source: position, or "
                        "leave the key out");
    }
}
