/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The finite elements of the hybrid model's paper once more, small and plain: linear tetrahedra
 * under (1) to (6), Green strain and viscous stress, lumped mass, symplectic Euler, double
 * precision, one loop over elements, sharing no code with the models. The report checks them
 * against it.
 *
 * In: a mesh, Lame constants, viscosities, mass damping, fixed nodes. What pushes: nodes that are
 * led, a dead force, or a ball by a penalty at samples of the surface. Out: places, forces,
 * energies, the stable step. No cure for locking; the guard of elements squeezed below 0.65 of
 * their volume, which is the program's and not the paper's, where it is asked for. Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"

typedef struct ss_heart_reference {
    const ss_mesh *mesh;   /* borrowed */
    double lambda, mu;     /* Pa */
    double phi, psi;       /* Pa s */
    double damping;        /* 1/s, of mass */
    bool is_guarded;       /* W += (lambda + 2 mu)/2 (0.65 - J)^2 below J = 0.65 */
    double (*slope)[4][3]; /* gradients of the shape functions, 1/m */
    double *volume;        /* m^3 an element */
    double *mass;          /* kg a node; density 1 */
    double *area;          /* m^2 a surface triangle */
    double (*u)[3], (*v)[3], (*force)[3];
    uint8_t *is_held;        /* fixed or led */
    double elastic, kinetic; /* J, of the last step */
    int32_t pushed;          /* node under a dead force; -1: none */
    double push[3];          /* N */
    /* The ball. */
    double ball[3], radius, stiffness; /* m, m, N/m^3; radius 0: none */
    double ball_force[3];              /* N on it, of the last step */
} ss_heart_reference;

/* Fixed are the nodes of `group`. False when out of memory. */
bool ss_heart_reference_init(ss_heart_reference *reference, const ss_mesh *mesh, double lambda,
                             double mu, const char *group);
void ss_heart_reference_fini(ss_heart_reference *reference);
/* Steps; held nodes stay where u has them. */
void ss_heart_reference_run(ss_heart_reference *reference, int32_t steps, double dt);
/* 2/omega of the stiffest motion at rest, by power iteration. False when out of memory. */
bool ss_heart_reference_stable_step(ss_heart_reference *reference, double *out_step);
/* The ball from where it is to `to` in `steps`. */
void ss_heart_reference_move(ss_heart_reference *reference, const double to[3], int32_t steps,
                             double dt);
