/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The network of net.h in motion, (28), with one law or another for the current of the
 * contact cell: the closure that the model uses, and the sources that the paper prints. For the
 * report's comparisons only: nothing here is in the product. Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>

#include "bench/papers/zhong2006/net.h"

typedef enum ss_zhong_source {
    SS_ZHONG_CLOSURE, /* I = E max(0, Q/Qhat) of the shape of now */
    SS_ZHONG_WORK,    /* (3), (4): I = F.U/A */
    SS_ZHONG_DENSITY  /* (5) to (9): I = sigma:eps over the triangles around the contact */
} ss_zhong_source;

typedef struct ss_zhong_law {
    ss_zhong_source source;
    bool is_length_current; /* |PiPj| of (26) as it is now; else at rest */
    double modulus;         /* E of the closure, N/m */
    double tensor[6][6];    /* C of (7): xx yy zz yz zx xy, x along the tube's axis, z outward */
    double mass, damping;   /* kg, N s/m, a node */
    double rest_stiffness;  /* ks, N/m a node; 0: no memory of rest */
} ss_zhong_law;

/* C from Young's moduli and shear moduli, Poisson's ratios 0.3 of the stiffer axis to the softer:
 * isotropic where all agree. False when that is no stable material. */
bool ss_zhong_hooke(double along, double across, double out_tensor[6][6]);

typedef struct ss_zhong_motion {
    const ss_zhong_net *net;
    const ss_zhong_law *law;
    int32_t contact;
    int32_t triangle_count; /* of the star */
    int32_t star[16][3];
    double axis[3]; /* along which the tensor's x lies; across no triangle of the star */
    double (*u)[3], (*v)[3];
    double force[3]; /* on the contact */
    double time;     /* s */
    double (*scratch)[3];
} ss_zhong_motion;

/* At rest, forceless. `triangle` are those of the net's surface; false when out of memory. */
bool ss_zhong_motion_init(ss_zhong_motion *motion, const ss_zhong_net *net, const ss_zhong_law *law,
                          int32_t contact, int32_t triangle_count, const int32_t (*triangle)[3]);
void ss_zhong_motion_fini(ss_zhong_motion *motion);
/* `count` classical Runge-Kutta steps of dt. */
void ss_zhong_motion_run(ss_zhong_motion *motion, int32_t count, double dt);
/* The current that the law gives now. */
double ss_zhong_motion_current(const ss_zhong_motion *motion);
/* The shortest edge over its length at rest. */
double ss_zhong_motion_shortest(const ss_zhong_motion *motion);
