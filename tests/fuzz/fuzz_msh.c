/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * libFuzzer over the MSH reader. A text that does not start with '$' is put behind the format line
 * of version 2.2, or 4.1 when it starts with '4', which the fuzzer would hardly find.
 */
#include "fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char two[] = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n";
    static const char four[] = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    if (size > 0 && data[0] == '4') {
        fuzz_text(ss_mesh_parse_msh, four, sizeof four - 1, data + 1, size - 1);
    } else {
        fuzz_text(ss_mesh_parse_msh, two, size > 0 && data[0] != '$' ? sizeof two - 1 : 0, data,
                  size);
    }
    return 0;
}
