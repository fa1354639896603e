/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/fem_elastic.h"
/*
 * The forces of the elastic body, and how they change: a sweep of the kernels over all elements,
 * with the pressures of the nodes where those resist dilatation.
 */
#include <math.h>

void ss_fem_force(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                  ss_body_energy *out)
{
    ss_fem *fem = owner;
    ss_fem_pass pass = {.blocks = &fem->blocks,
                        .kind = fem->kind,
                        .u = u,
                        .v = v,
                        .out = force,
                        .wants_energy = out->is_wanted};
    if (fem->average.modulus) {
        pass.energy = ss_fem_average_update(fem, u, out->is_wanted);
        pass.pressure = fem->average.pressure;
    }
    fem->kernels->force(&pass);
    fem->u = u;
    fem->stability.strain = fmax(fem->stability.strain, sqrt(pass.strain));
    out->elastic = pass.energy;
    out->power = pass.power;
}

void ss_fem_tangent(void *owner, const ss_real *x, ss_real *out)
{
    ss_fem *fem = owner;
    ss_fem_pass pass = {.blocks = &fem->blocks, .kind = fem->kind, .u = fem->u, .x = x, .out = out};
    if (fem->average.modulus) {
        ss_fem_average_change(fem, x);
        pass.pressure = fem->average.pressure;
        pass.change = fem->average.change;
    }
    fem->kernels->tangent(&pass);
}

void ss_fem_diagonal(void *owner, double *diagonal)
{
    const ss_fem *fem = owner;
    ss_fem_add_diagonal(fem->blocks.node_count, fem->diagonal, diagonal);
}
