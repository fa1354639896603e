/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * libFuzzer over the reader of legacy VTK. A text that does not start with '#' is put behind one of
 * four heads, ASCII or binary, of the old or the new layout, as the low bits of its first byte say.
 */
#include "fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const heads[] = {
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET ",
        "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET ",
        "# vtk DataFile Version 5.1\nt\nASCII\nDATASET ",
        "# vtk DataFile Version 5.1\nt\nBINARY\nDATASET ",
    };
    if (size > 0 && data[0] != '#') {
        const char *head = heads[data[0] & 3];
        fuzz_text(ss_mesh_parse_vtk, head, strlen(head), data + 1, size - 1);
    } else {
        fuzz_text(ss_mesh_parse_vtk, "", 0, data, size);
    }
    return 0;
}
