/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Organ-like bodies as level sets f(x) = 0, f < 0 inside, each star-shaped about a centre, in
 * metres. The kidney lies along x with its hilum on the -y side, the liver with its right lobe
 * towards -x; z is up.
 */
#include <stdint.h>

typedef enum organ_kind { ORGAN_KIDNEY, ORGAN_LIVER, ORGAN_ELLIPSOID } organ_kind;

typedef struct organ {
    organ_kind kind;
    double half[3];   /* about half of the extent along x, y, z */
    double centre[3]; /* sees the whole surface */
} organ;

void organ_init(organ *o, organ_kind kind, const double ellipsoid_half[3]);

/* f at x. */
double organ_value(const organ *o, const double x[3]);
/* f and its gradient at x. */
double organ_level(const organ *o, const double x[3], double out_gradient[3]);

/* The point of the surface seen from the centre along `direction` (a unit vector of the sphere
 * that is stretched to the body's extent). */
void organ_place(const organ *o, const double direction[3], double out[3]);

/* Moves x onto the nearby surface: Newton steps along the gradient. */
void organ_project(const organ *o, double x[3], int steps);
