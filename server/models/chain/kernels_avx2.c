/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The kernels again, with the flags -mavx2 -mfma that the build gives this file alone. */
#include "models/chain/kernels.c"
