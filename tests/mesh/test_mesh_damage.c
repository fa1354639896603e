/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Each good file of the table of formats, cut at every byte, damaged at random, and read through
 * windows of any size: whatever comes of it must be a sound mesh or an error, and no memory may
 * stay behind.
 */
#include "common/test.h"

#include <sys/mman.h>
#include <unistd.h>

#include "format_cases.h"
#include "mesh/readers.h"
#include "rt/memory.h"
#include "rt/random.h"

static softsim_status parse_texts(const file_case *c, const char *data, ss_text *text,
                                  ss_text *other, ss_mesh **out)
{
    if (c->other_name != NULL) {
        const bool is_node = strstr(c->name, "node") != NULL || strstr(c->name, "NODE") != NULL;
        return ss_mesh_parse_tetgen(is_node ? text : other, is_node ? other : text, 1.0, out);
    }
    const bool is_off = strstr(c->name, ".off") != NULL || strncmp(data, "# by hand", 9) == 0;
    return strstr(data, "<VTKFile") != NULL ? ss_mesh_parse_vtu(text, 1.0, out)
           : is_off                         ? ss_mesh_parse_off(text, 1.0, out)
           : strncmp(data, "# vtk", 5) == 0 ? ss_mesh_parse_vtk(text, 1.0, out)
                                            : ss_mesh_parse_msh(text, 1.0, out);
}

/* By the reader for the case's format, from an exact copy on the heap. */
static softsim_status parse(const file_case *c, const char *data, size_t size, ss_mesh **out,
                            softsim_error *error)
{
    char *copy = malloc(size > 0 ? size : 1);
    assert_non_null(copy);
    memcpy(copy, data, size);
    ss_text text;
    ss_text other = {0};
    ss_text_init(&text, copy, size, "t", error);
    if (c->other_name != NULL) {
        ss_text_init(&other, c->other_text, strlen(c->other_text), "o", error);
    }
    const softsim_status status = parse_texts(c, data, &text, &other, out);
    free(copy);
    return status;
}

static void expect_sound(const file_case *c, const char *data, size_t size)
{
    ss_mesh *m = NULL;
    softsim_error error = {0};
    const softsim_status status = parse(c, data, size, &m, &error);
    if ((status == SOFTSIM_OK) != (m != NULL) || (m == NULL) != (error.fault_count > 0)) {
        fail_msg("%s: status %d with %d faults: %s", c->name, status, error.fault_count,
                 error.text);
    }
    if (m != NULL) {
        ss_mesh_report r;
        assert_int_equal(ss_mesh_check(m, &r), SOFTSIM_OK);
        assert_int_equal(r.bad_index.count, 0);
        assert_int_equal(r.non_finite.count, 0);
        for (int32_t g = 0; g < m->group_count; ++g) {
            for (int32_t i = 0; i < m->group[g].node_count; ++i) {
                assert_in_range(m->group[g].node[i], 0, m->node_count - 1);
            }
        }
    }
    ss_mesh_destroy(&m);
}

static bool is_good(const file_case *c)
{
    return c->expected[0] != '!' && strncmp(c->name, "mark", 4) != 0;
}

TEST(good_files_cut_anywhere_are_sound_or_refused)
{
    const int64_t before = ss_memory_in_use();
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        static char data[8192];
        const size_t size = is_good(&cases[i]) ? make_bytes(&cases[i], data, sizeof data) : 0;
        data[size] = '\0';
        for (size_t length = 0; length < size; ++length) {
            expect_sound(&cases[i], data, length);
        }
    }
    assert_int_equal(ss_memory_in_use(), before);
}

TEST(good_files_damaged_at_random_are_sound_or_refused)
{
    static const char alphabet[] = "0123456789 -+.e$<>\"/#\n\r\tnaN\0\377\200";
    const int64_t before = ss_memory_in_use();
    uint64_t random = 411;
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        static char data[8192];
        for (int round = 0; is_good(&cases[i]) && round < 300; ++round) {
            const size_t size = make_bytes(&cases[i], data, sizeof data);
            data[size] = '\0';
            for (int k = 0; k < 1 + round % 4; ++k) {
                const size_t at = ss_random_next(&random) % size;
                data[at] = alphabet[ss_random_next(&random) % (sizeof alphabet - 1)];
            }
            expect_sound(&cases[i], data, size);
        }
    }
    assert_int_equal(ss_memory_in_use(), before);
}

/* From a file in memory, through a window. */
static void open_text(const char *data, size_t size, size_t window, ss_text *out,
                      softsim_error *error)
{
    const int fd = memfd_create("text", 0);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, data, size), size);
    assert_true(ss_text_open(out, fd, (int64_t)size, window, "t", error));
}

TEST(windows_of_any_size_show_the_same)
{
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        const file_case *c = &cases[i];
        static char data[8192];
        const size_t size = is_good(c) ? make_bytes(c, data, sizeof data) : 0;
        data[size] = '\0';
        for (size_t window = 180; size > 0 && window < 400; window += 7) {
            ss_text text;
            ss_text other = {.fd = -1};
            ss_mesh *m = NULL;
            softsim_error error = {0};
            char got[1024] = "";
            open_text(data, size, window, &text, &error);
            if (c->other_name != NULL) {
                open_text(c->other_text, strlen(c->other_text), window, &other, &error);
            }
            (void)parse_texts(c, data, &text, &other, &m);
            if (m != NULL) {
                summarise(m, got, sizeof got);
            }
            if (strcmp(got, c->expected) != 0) {
                fail_msg("%s, window of %zu: %s%s", c->name, window, got, error.text);
            }
            ss_mesh_destroy(&m);
            (void)close(text.fd);
            (void)close(other.fd);
            ss_text_fini(&text);
            ss_text_fini(&other);
        }
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
