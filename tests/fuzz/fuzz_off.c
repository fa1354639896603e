/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * libFuzzer over the reader of OFF. A text that starts with a digit is put behind the head and the
 * places of nine vertices, so that faces of many corners are tried at once.
 */
#include "fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char head[] = "OFF 9 2 0\n0 0 0\n1 0 0\n2 0 0\n2 1 0\n2 2 0\n1 .5 0\n0 2 0\n"
                               "0 1 0\n0 0 1\n";
    const bool is_faces = size > 0 && data[0] >= '0' && data[0] <= '9';
    fuzz_text(ss_mesh_parse_off, head, is_faces ? sizeof head - 1 : 0, data, size);
    return 0;
}
