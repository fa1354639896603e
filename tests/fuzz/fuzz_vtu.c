/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* libFuzzer over the reader of VTK's XML grids. */
#include "fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_text(ss_mesh_parse_vtu, "", 0, data, size);
    return 0;
}
