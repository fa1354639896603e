/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Private to coarse.c and hats.c: the state of the coarse level. coarse.c has the equations.
 * Memory: the model's arena. Thread: as chain.h says.
 */
#include "models/chain/chain.h"

struct ss_chain_coarse {
    bool is_aggregated;
    double rate;    /* 1/s of the aggregated cells alone */
    int32_t *own;   /* of an element: steps that it is a cell of its own for; aggregated */
    int32_t *queue; /* those elements; scratch of finding them */
    int32_t own_count;
    int32_t cells, row; /* row: padded to a multiple of 4 */
    double spacing;     /* m */
    double lambda;      /* of L for the mean capacitance */
    ss_chain_hats hats;
    int32_t *slot;       /* of an element: block x hats.block + place in it */
    double *weight;      /* Phi: of an element (by slot), one for each entry of its block */
    int64_t *first;      /* of a block's weights */
    ss_real *mask;       /* 1 where an element takes part, quads */
    int32_t *out, *idle; /* elements left out, and for how long without need */
    int32_t out_count;
    bool is_stale;                   /* the inverse is of another matrix */
    double *base, *matrix;           /* Phi'LPhi without tools, and now; cells x cells */
    double *factor, *solved;         /* scratch of the inverse */
    ss_real *base_inverse, *inverse; /* D, rows of `row` */
    ss_real *gathered, *moved;       /* a quad a cell */
};

/* Blocks of elements and the hats of all cells over them, at farthest points of the mesh; cells,
 * row and is_aggregated are set. Thread: set-up only. */
softsim_status ss_chain_hats_create(ss_chain_coarse *coarse, const ss_mesh *mesh, double diagonal,
                                    ss_arena *arena);
