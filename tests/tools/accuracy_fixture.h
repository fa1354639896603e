/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A case of one tetrahedron and a call of softsim-bench accuracy: shared by its tests. cmocka comes
 * first. */
#include <stdint.h>

#include "bench/bench.h"
#include "common/folder_fixture.h"
#include "common/number_fixture.h"

#define REFERENCE SOURCE_DIR "/tests/reference"

static const char good_mesh[] =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n7 0 0 0\n3 1 0 0\n9 0 1 0\n2 0 0 1\n"
    "$EndNodes\n$Elements\n1\n1 4 2 1 1 7 3 9 2\n$EndElements\n";
static const char good_sets[] = "{\"fixed\":[7,3,9],\"patch\":[2]}";
static const char good_reference[] =
    "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,.1,0,0,-.001\n3,1,0,0,.1,0,0,0\n7,0,0,0,.1,0,0,0\n"
    "9,0,1,0,.1,0,0,0\n";

/* Options end with NULL; what is written to `stream` goes to the file `to`. */
static inline int run_accuracy(const char *const *option, FILE *stream, const char *to)
{
    char *argv[16] = {"softsim-bench accuracy"};
    int argc = 1;
    for (; option[argc - 1] != NULL; ++argc) {
        argv[argc] = (char *)(uintptr_t)option[argc - 1];
    }
    const int kept = divert(stream, to);
    const int result = ss_report_accuracy.run(argc, argv);
    restore(stream, kept);
    return result;
}
