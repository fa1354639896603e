/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* libFuzzer over the TetGen reader: the text of the .node file, an '@', that of the .ele file. */
#include "fuzz_mesh.h"

static const char *elements;
static size_t elements_size;

static softsim_status parse_pair(ss_text *nodes, double metres_per_unit, ss_mesh **out_mesh)
{
    ss_text text;
    ss_text_init(&text, elements, elements_size, "elements", nodes->error);
    return ss_mesh_parse_tetgen(nodes, &text, metres_per_unit, out_mesh);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const uint8_t *split = size > 0 ? memchr(data, '@', size) : NULL;
    const size_t first = split != NULL ? (size_t)(split - data) : size;
    elements_size = split != NULL ? size - first - 1 : 0;
    char *copy = malloc(elements_size > 0 ? elements_size : 1);
    require(copy != NULL);
    if (elements_size > 0) {
        memcpy(copy, split + 1, elements_size);
    }
    elements = copy;
    fuzz_text(parse_pair, "", 0, data, first);
    free(copy);
    return 0;
}
