/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Each file of a table of formats gets the mesh or the error that the table says. */
#include "common/test.h"

#include "format_cases.h"
#include "rt/memory.h"

static bool is_as_expected(const file_case *c, const char *got, const softsim_error *error)
{
    if (c->expected[0] != '!') {
        return error->fault_count == 0 && strcmp(got, c->expected) == 0;
    }
    return error->fault_count == 1 && strncmp(got, folder, strlen(folder)) == 0 &&
           strchr(got, '\n') == NULL && strstr(got, c->expected + 1) != NULL;
}

TEST(each_file_gets_what_the_table_says)
{
    int32_t wrong = 0;
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        const file_case *c = &cases[i];
        static char data[8192];
        char got[SOFTSIM_ERROR_TEXT_SIZE];
        write_bytes(c->name, data, make_bytes(c, data, sizeof data));
        if (c->other_name != NULL) {
            write_bytes(c->other_name, c->other_text, strlen(c->other_text));
        }
        ss_mesh *m = NULL;
        softsim_error error = {0};
        const int64_t before = ss_memory_in_use();
        const softsim_status status = ss_mesh_load(in_folder(c->name), 1.0, NULL, &m, &error);
        assert_true((status == SOFTSIM_OK) == (m != NULL));
        if (m != NULL) {
            summarise(m, got, sizeof got);
        } else {
            memcpy(got, error.text, sizeof got);
        }
        ss_mesh_destroy(&m);
        assert_int_equal(ss_memory_in_use(), before);
        const char *shown =
            strncmp(got, folder, strlen(folder)) == 0 ? got + strlen(folder) + 1 : got;
        const bool is_right = is_as_expected(c, got, &error);
        print_message("%-5s %-24s %s\n", is_right ? "" : "WRONG", c->name, shown);
        wrong += !is_right;
    }
    print_message("%d files\n", COUNT(cases));
    assert_int_equal(wrong, 0);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
