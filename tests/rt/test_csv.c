/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* rt/csv: cells as spreadsheets write them; columns by name; every fault has its place. */
#include "common/test.h"

#include <math.h>

#include "common/folder_fixture.h"
#include "common/number_fixture.h"
#include "rt/csv.h"

TEST(cells_are_cut_at_commas)
{
    static const struct {
        const char *line;
        int count;
        const char *cell[4];
    } cases[] = {
        {"a,b", 2, {"a", "b"}},
        {" a\t, b c ", 2, {"a", "b c"}},
        {"", 1, {""}},
        {",,", 3, {"", "", ""}},
        {"\"a, b\",c", 2, {"a, b", "c"}},
        {"\"say \"\"a\"\"\"  ,c", 2, {"say \"a\"", "c"}},
        {"\"never closed, c", 1, {"never closed, c"}},
        {"1,2,3,4,5", 5, {"1", "2", "3", "4"}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char line[64], *cell[4];
        strcpy(line, cases[i].line);
        assert_int_equal(ss_csv_split(line, cell, 4), cases[i].count);
        for (int k = 0; k < 4 && k < cases[i].count; ++k) {
            assert_string_equal(cell[k], cases[i].cell[k]);
        }
    }
}

TEST(blank_lines_and_comments_are_passed_over)
{
    char blank[] = " \t\r\n", comment[] = "  # a,b\n", row[] = "  1, 2 \r\n";
    assert_null(ss_csv_trim(blank));
    assert_null(ss_csv_trim(comment));
    assert_string_equal(ss_csv_trim(row), "1, 2");
}

TEST(columns_are_found_by_name_and_faults_have_their_line)
{
    static const char *const name[] = {"b", "a", "c"};
    static char longer[10000];
    softsim_error error = {.status = SOFTSIM_OK};
    ss_csv csv;
    double value[3];
    const char *path =
        write_text("good.csv", SS_CSV_MARK "a,x,b\r\n1,,2\n\n3,y,nan\n4,z,5z\n6,z\n7,,8");
    assert_int_equal(ss_csv_open(&csv, path, name, 3, 2, &error), SOFTSIM_OK);
    assert_string_equal(csv.head, "a,x,b");
    assert_int_equal(ss_csv_next(&csv, value, &error), 1);
    assert_near(value[0], 2.0, 0.0);
    assert_near(value[1], 1.0, 0.0);
    assert_true(isnan(value[2]));
    assert_int_equal(ss_csv_next(&csv, value, &error), 1);
    assert_true(isnan(value[0]));
    assert_int_equal(ss_csv_next(&csv, value, &error), -1);
    assert_non_null(strstr(error.text, "good.csv:5: column 3: '5z' is not a number"));
    assert_int_equal(ss_csv_next(&csv, value, &error), -1);
    assert_non_null(strstr(error.text, "good.csv:6: column 3: '' is not a number"));
    assert_int_equal(ss_csv_next(&csv, value, &error), 1);
    assert_near(value[0], 8.0, 0.0);
    assert_int_equal(ss_csv_next(&csv, value, &error), 0);
    assert_int_equal(ss_csv_next(&csv, value, &error), 0);
    ss_csv_close(&csv);

    assert_int_equal(ss_csv_open(&csv, path, name, 3, 3, &error), SOFTSIM_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "good.csv:1: no column 'c'"));
    memset(longer, 'a', sizeof longer - 1);
    assert_int_equal(ss_csv_open(&csv, write_text("long.csv", longer), name, 1, 1, &error),
                     SOFTSIM_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "long.csv:1: longer"));
    assert_int_equal(ss_csv_open(&csv, in_folder("none.csv"), name, 1, 1, &error),
                     SOFTSIM_ERROR_FILE);
    memset(longer, ',', 200);
    longer[200] = '\0';
    assert_int_equal(ss_csv_open(&csv, write_text("wide.csv", longer), name, 1, 0, &error),
                     SOFTSIM_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "wide.csv:1: more than 64 columns"));
}

/* Comments and blank lines may stand before it. */
TEST(faults_of_the_head_have_its_line)
{
    static const char *const name[] = {"b"};
    char wide[240] = "# made by hand\n\n";
    softsim_error error = {.status = SOFTSIM_OK};
    ss_csv csv;
    assert_int_equal(
        ss_csv_open(&csv, write_text("late.csv", "\n# t\n\na,c\n1,2\n"), name, 1, 1, &error),
        SOFTSIM_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "late.csv:4: no column 'b'"));
    memset(wide + strlen(wide), ',', 200);
    assert_int_equal(ss_csv_open(&csv, write_text("wide.csv", wide), name, 1, 0, &error),
                     SOFTSIM_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "wide.csv:3: more than 64 columns"));
    assert_int_equal(ss_csv_open(&csv, write_text("empty.csv", ""), name, 1, 1, &error),
                     SOFTSIM_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "empty.csv:1: no column 'b'"));
}

/* It would hide the rest of its line. The last one is UTF-16. */
TEST(a_nul_is_refused)
{
    static const char *const name[] = {"a"};
    static const struct {
        const char *bytes;
        size_t size;
        const char *fault;
    } cases[] = {
        {"a,b\n1,2\0,3\n4,5\n", 15, ":2: a NUL at character 4"},
        {"a,b\n1,2\0", 8, ":2: a NUL at character 4"},
        {"a,b\n\0\n", 6, ":2: a NUL at character 1"},
        {"a\0,b\n1,2\n", 9, ":1: a NUL at character 2"},
        {"\xff\xfe"
         "a\0,\0b\0\n\0",
         10, ":1: a NUL at character 4"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        softsim_error error = {.status = SOFTSIM_OK};
        ss_csv csv;
        double value = 0.0;
        const char *path = write_bytes("nul.csv", cases[i].bytes, cases[i].size);
        if (ss_csv_open(&csv, path, name, 1, 1, &error) == SOFTSIM_OK) {
            assert_int_equal(ss_csv_next(&csv, &value, &error), -1);
            ss_csv_close(&csv);
        }
        if (strstr(error.text, cases[i].fault) == NULL) {
            fail_msg("'%s' is not in: %s", cases[i].fault, error.text);
        }
    }
}

/* One row each, after the head line a,b. */
TEST(strict_rows_are_whole_and_finite)
{
    static const char *const name[] = {"a"};
    static const says_row cases[] = {
        {"1,2", NULL},
        {"1,inf", ":2: column 2: 'inf' is not a finite number"},
        {"1,x", ":2: column 2: 'x' is not a finite number"},
        {"nan,2", ":2: column 1: 'nan' is not a finite number"},
        {"1", ":2: 1 columns, not the 2"},
        {"1,2,3", ":2: 3 columns, not the 2"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[64];
        softsim_error error = {.status = SOFTSIM_OK};
        ss_csv csv;
        double value = 0.0;
        snprintf(text, sizeof text, "a,b\n%s\n", cases[i].given);
        assert_int_equal(ss_csv_open(&csv, write_text("strict.csv", text), name, 1, 1, &error),
                         SOFTSIM_OK);
        csv.is_strict = true;
        assert_int_equal(ss_csv_next(&csv, &value, &error), cases[i].says == NULL ? 1 : -1);
        if (cases[i].says != NULL && strstr(error.text, cases[i].says) == NULL) {
            fail_msg("'%s' is not in: %s", cases[i].says, error.text);
        }
        ss_csv_close(&csv);
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
