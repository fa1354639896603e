/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Symmetric sparse matrices of 3x3 blocks, one row of blocks a node, and their solution on the axes
 * that are free, in double: what the static reference solutions need.
 *
 * In: which nodes are neighbours (the tetrahedra), blocks added element by element. Out: products
 * and solutions. Memory belongs to the matrix. Thread: one at a time, set-up and tools only.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

typedef struct ss_block_matrix {
    int32_t node_count;
    int32_t *first;    /* of a row's entries; node_count + 1 */
    int32_t *column;   /* increasing within a row */
    int32_t *diagonal; /* entry of the row's own node */
    double (*block)[9];
    double (*inverse)[9]; /* of the diagonal blocks' free part, by ss_block_matrix_prepare */
    double (*work)[3];    /* 5 node_count */
} ss_block_matrix;

/* All blocks zero, one for each pair of nodes of a tetrahedron. */
softsim_status ss_block_matrix_create(int32_t node_count, int32_t tetrahedron_count,
                                      const int32_t (*tetrahedron)[4],
                                      ss_block_matrix **out_matrix);
void ss_block_matrix_destroy(ss_block_matrix **matrix);
void ss_block_matrix_clear(ss_block_matrix *matrix);
/* Entry of the block (row, column), -1 where the pattern has none. */
int32_t ss_block_matrix_find(const ss_block_matrix *matrix, int32_t row, int32_t column);
/* y = A x over all axes. */
void ss_block_matrix_multiply(const ss_block_matrix *matrix, const double (*x)[3], double (*y)[3]);
/* Inverts what ss_block_matrix_solve divides by; after the blocks or `held` (a node's bits: 1 x, 2
 * y, 4 z) have changed. */
void ss_block_matrix_prepare(ss_block_matrix *matrix, const uint8_t *held);
/* A x = b on the free axes, x = 0 on held ones, to |b - A x| <= tolerance |b|. Stops at a direction
 * in which A is not positive, with what it has by then (the direction itself if there is nothing),
 * and after max_iterations. Returns the residual that is left over |b|; *out_is_positive may be
 * NULL. */
double ss_block_matrix_solve(ss_block_matrix *matrix, const uint8_t *held, const double (*b)[3],
                             double tolerance, int32_t max_iterations, double (*x)[3],
                             bool *out_is_positive);
