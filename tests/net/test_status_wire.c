/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The list of softsim/status.h and its message: the same fields in the same order. */
#include "common/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "net/status_wire.h"

typedef struct declared {
    const char *type, *name;
    int count; /* 0: no array */
} declared;

static const declared list[] = {
#define SCALAR(type, name, line, text)       {#type, #name, 0},
#define ARRAY(type, name, count, line, text) {#type, #name, count},
#define TEXT(name, line)                     {"string", #name, 0},
    SOFTSIM_SERVER_STATUS_LIST(SCALAR, ARRAY, TEXT)
#undef SCALAR
#undef ARRAY
#undef TEXT
};

TEST(the_list_is_the_lcm_file)
{
    FILE *file = fopen(SOURCE_DIR "/lcmtypes/server_status_t.lcm", "re");
    assert_non_null(file);
    char line[256];
    size_t i = 0;
    while (fgets(line, sizeof line, file) != NULL) {
        char type[16], name[64];
        int count = 0;
        line[strcspn(line, ";/")] = '\0';
        if (sscanf(line, " %15s %63[a-z0-9_][%d]", type, name, &count) < 2 ||
            strcmp(type, "package") == 0 || strcmp(type, "struct") == 0) {
            continue;
        }
        assert_true(i < sizeof list / sizeof *list);
        assert_string_equal(name, list[i].name);
        assert_string_equal(type, list[i].type);
        assert_int_equal(count, list[i].count);
        ++i;
    }
    assert_int_equal(i, sizeof list / sizeof *list);
    assert_int_equal(fclose(file), 0);
}

/* Byte by byte: every field of one is that field of the other. */
TEST(a_status_comes_back_from_the_wire)
{
    static char texts[] = "scene", model[] = "model", reason[] = "reason";
    softsim_server_status sent, back;
    unsigned char *at = (unsigned char *)&sent;
    for (size_t i = 0; i < sizeof sent; ++i) {
        at[i] = (unsigned char)(i * 37 + 1);
    }
    sent.scene = texts;
    sent.model = model;
    sent.reason = reason;
    softsim_server_status_t wire, decoded;
    ss_status_to_wire(&sent, &wire);
    uint8_t message[4096];
    const int size = softsim_server_status_t_encode(message, 0, sizeof message, &wire);
    assert_int_equal(size, ss_status_texts_at + 3 * 5 + (int64_t)(5 + 5 + 6));
    double uptime = 0.0;
    uint64_t bits = 0;
    for (int i = 0; i < 8; ++i) {
        bits = bits << 8 | message[ss_status_uptime_at + i];
    }
    memcpy(&uptime, &bits, sizeof uptime);
    assert_memory_equal(&uptime, &sent.uptime_s, sizeof uptime);
    assert_int_equal(softsim_server_status_t_decode(message, 0, size, &decoded), size);
    ss_status_from_wire(&decoded, &back);
#define SCALAR(type, name, line, text)                                                             \
    assert_memory_equal(&back.name, &sent.name, sizeof sent.name);
#define ARRAY(type, name, count, line, text)                                                       \
    assert_memory_equal(back.name, sent.name, sizeof sent.name);
#define TEXT(name, line) assert_string_equal(back.name, sent.name);
    SOFTSIM_SERVER_STATUS_LIST(SCALAR, ARRAY, TEXT)
#undef SCALAR
#undef ARRAY
#undef TEXT
    softsim_server_status_t_decode_cleanup(&decoded);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
