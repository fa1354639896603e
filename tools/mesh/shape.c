/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Lengths in the formulas are millimetres, for the organs' dimensions are.
 *
 * Kidney: an ellipsoid-like body about a bent axis, y_c = -B x^2, with blunt poles (exponent 2.4
 * along x) and a hollow at the hilum: f = |x/a|^2.4 + ((y - y_c)/b)^2 + (z/c)^2 - 1 + hollow.
 * Liver: two ellipsoidal lobes joined by a smooth minimum, -log(exp(-k f1) + exp(-k f2)) / k, less
 * a fissure below and a hollow on the underside.
 * Gradients by central differences: f is smooth, and only the direction and the rate of
 * convergence hang on them, not the surface.
 */
#include "shape.h"

#include "rt/vec.h"

static const double mm = 1e-3;

static double square(double x)
{
    return x * x;
}

static double kidney_level(const double x[3])
{
    const double bend = 0.0062;
    const double upper = 1.0 + 0.0013 * x[0]; /* one pole is a little stouter */
    const double y = x[1] - 3.0 + bend * x[0] * x[0];
    const double hollow =
        0.62 * exp(-square(x[0] / 15.0) - square(x[2] / 16.0) - square((x[1] + 24.0) / 15.0));
    return pow(square(x[0] / 54.9), 1.2) + square(y / (27.5 * upper)) +
           square(x[2] / (22.5 * upper)) - 1.0 + hollow;
}

static double lobe(const double x[3], const double centre[3], const double half[3])
{
    double d[3];
    ss_sub3(d, x, centre);
    return sqrt(square(d[0] / half[0]) + square(d[1] / half[1]) + square(d[2] / half[2])) - 1.0;
}

static double liver_level(const double x[3])
{
    static const double right_centre[3] = {-36.0, 0.0, 0.0};
    static const double right_half[3] = {64.0, 62.0, 45.0};
    static const double left_centre[3] = {30.0, 10.0, 12.0};
    static const double left_half[3] = {70.0, 46.0, 24.0};
    const double sharpness = 6.0;
    const double right = lobe(x, right_centre, right_half);
    const double left = lobe(x, left_centre, left_half);
    const double both = -log(exp(-sharpness * right) + exp(-sharpness * left)) / sharpness;
    const double fissure = 0.30 * exp(-square((x[0] - 18.0) / 11.0) - square((x[1] + 46.0) / 20.0));
    const double underside =
        0.30 * exp(-square((x[0] + 5.0) / 50.0) - square((x[1] + 12.0) / 38.0) -
                   square((x[2] + 40.0) / 18.0));
    return both + fissure + underside;
}

double organ_value(const organ *o, const double x[3])
{
    double y[3];
    switch (o->kind) {
    case ORGAN_KIDNEY:
        ss_scale3(y, x, 1.0 / mm);
        return kidney_level(y);
    case ORGAN_LIVER:
        ss_scale3(y, x, 1.0 / mm);
        return liver_level(y);
    case ORGAN_ELLIPSOID:
        break;
    }
    return square(x[0] / o->half[0]) + square(x[1] / o->half[1]) + square(x[2] / o->half[2]) - 1.0;
}

void organ_init(organ *o, organ_kind kind, const double ellipsoid_half[3])
{
    *o = (organ){.kind = kind};
    switch (kind) {
    case ORGAN_KIDNEY:
        ss_set3(o->half, 55.0 * mm, 30.0 * mm, 22.5 * mm);
        ss_set3(o->centre, 0.0, 4.0 * mm, 0.0);
        break;
    case ORGAN_LIVER:
        ss_set3(o->half, 100.0 * mm, 60.0 * mm, 42.0 * mm);
        ss_set3(o->centre, 0.0, 8.0 * mm, 8.0 * mm);
        break;
    case ORGAN_ELLIPSOID:
        ss_copy3(o->half, ellipsoid_half);
        break;
    }
}

double organ_level(const organ *o, const double x[3], double out_gradient[3])
{
    for (int k = 0; k < 3; ++k) {
        const double step = 1e-5 * o->half[k];
        double y[3];
        ss_copy3(y, x);
        y[k] = x[k] + step;
        const double above = organ_value(o, y);
        y[k] = x[k] - step;
        out_gradient[k] = (above - organ_value(o, y)) / (2.0 * step);
    }
    return organ_value(o, x);
}

void organ_place(const organ *o, const double direction[3], double out[3])
{
    const double ray[3] = {direction[0] * o->half[0], direction[1] * o->half[1],
                           direction[2] * o->half[2]};
    /* The first change of sign on the way out, then bisection. */
    const double stride = 1.0 / 24.0;
    double outside = stride;
    for (int i = 0; i < 240; ++i) {
        ss_madd3(out, o->centre, outside, ray);
        if (organ_value(o, out) > 0.0) {
            break;
        }
        outside += stride;
    }
    double inside = outside - stride;
    for (int i = 0; i < 44; ++i) {
        const double middle = 0.5 * (inside + outside);
        ss_madd3(out, o->centre, middle, ray);
        if (organ_value(o, out) > 0.0) {
            outside = middle;
        } else {
            inside = middle;
        }
    }
}

void organ_project(const organ *o, double x[3], int steps)
{
    for (int i = 0; i < steps; ++i) {
        double gradient[3];
        const double f = organ_level(o, x, gradient);
        const double slope = ss_dot3(gradient, gradient);
        if (slope > 0.0) {
            ss_madd3(x, x, -f / slope, gradient);
        }
    }
}
