/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What tissues are made of, each value with who measured it. Of soft tissue every number depends on
 * how it was measured: these are small strains at rest, means over people or animals, and a start
 * for what softsim-fit finds from a curve of one's own. Values that nobody here could place in the
 * literature are left out.
 */
#include <stdio.h>

typedef struct tissue {
    const char *name;
    double youngs_modulus; /* Pa */
    double density;        /* kg/m^3; ICRU Report 44 (1989) */
    double toughness;      /* J/m^2, of a cut or crack; 0: not known here. No model tears yet */
    const char *modulus_source, *toughness_source;
} tissue;

/* Poisson's ratio and damping (1/s, of motion in proportion to mass) of all of them, and why. */
extern const double tissue_poisson_ratio, tissue_damping;

/* NULL: there is none of that name. */
const tissue *tissue_find(const char *name);
/* "liver, kidney, ..." */
void tissue_names(char *out, size_t size);
/* The table, for people. */
void tissue_print(FILE *out);
