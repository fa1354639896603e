/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The kernels' scalar type: float by default, double with -DSOFTSIM_DOUBLE=ON for checks to
 * rounding error. Only models/ and contact/ hold ss_real arrays; everything else is double.
 * Node arrays of kernels are packed x y z 0, four scalars a node, 64-byte aligned.
 */
#ifdef SOFTSIM_DOUBLE
typedef double ss_real;
#define SS_REAL_DIGITS 17
#else
typedef float ss_real;
#define SS_REAL_DIGITS 9
#endif
