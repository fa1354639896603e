/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench scaling, run as people run it on the smallest bodies: every model's row has a time
 * per step, and says by what its linear equations are solved.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "assay.h"
#include "table.h"

static char folder[] = "/tmp/test_scaling_XXXXXX";

static const char *cell(const ss_table *table, int32_t row, const char *name)
{
    softsim_error error = {.status = SOFTSIM_OK};
    const int32_t column = ss_table_find(table, name, &error);
    assert_true(column >= 0);
    return ss_table_cell(table, row, column);
}

static bool begins(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

static void every_row_has_a_time_and_names_its_solver(void **state)
{
    (void)state;
    char command[512], path[128];
    ss_table table;
    softsim_error error = {.status = SOFTSIM_OK};
    int32_t blocks = 0;
    snprintf(command, sizeof command,
             BIN_DIR "/softsim-bench scaling --points 300 --out %s/report > %s/out 2>&1", folder,
             folder);
    assert_int_equal(system(command), 0);
    snprintf(path, sizeof path, "%s/report/scaling.csv", folder);
    assert_int_equal(ss_table_load(path, &table, &error), SOFTSIM_OK);
    for (int32_t i = 0; i < table.row_count; ++i) {
        const bool is_block = strcmp(cell(&table, i, "case"), "block") == 0;
        const char *model = cell(&table, i, "model"), *solver = cell(&table, i, "solver");
        const char *time = cell(&table, i, "step_us_p50");
        if (!(strtod(time, NULL) > 0.0) || begins(cell(&table, i, "verdict"), "refused")) {
            fail_msg("%s: '%s' us: %s", model, time, cell(&table, i, "verdict"));
        }
        if (is_block && begins(model, "cnn-energy")) {
            assert_true(begins(solver, "a factor of "));
        } else if (is_block && begins(model, "corotational")) {
            assert_true(begins(solver, "conjugate gradients"));
        }
        blocks += is_block;
    }
    assert_int_equal(blocks, ss_assay_subject_count());
    ss_table_fini(&table);
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) != NULL ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_row_has_a_time_and_names_its_solver),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
