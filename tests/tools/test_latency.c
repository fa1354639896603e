/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-bench latency as a whole: every program of the chain is started, measured and stopped.
 * How late they are is the machine's affair; that there is a report, and nothing but it, is
 * claimed. */
#include "common/test.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "common/folder_fixture.h"
#include "process/process.h"

/* The last of the six columns in the line of `name`. */
static long long read_count(const char *csv, const char *name)
{
    char start[64];
    (void)snprintf(start, sizeof start, "\n%s,", name);
    const char *at = strstr(csv, start);
    for (int column = 0; column < 5 && at != NULL; ++column) {
        at = strchr(at + 1, ',');
    }
    assert_non_null(at);
    return atoll(at + 1);
}

TEST(a_report_of_the_chain_is_made_to_its_end)
{
    static process bench;
    char csv[4096];
    const char *const argv[] = {"softsim-bench",
                                "latency",
                                "--seconds",
                                "3",
                                "--scene",
                                SOURCE_DIR "/server/scenes/kidney.yaml",
                                "--poses",
                                SOURCE_DIR "/server/scenes/kidney-poke.lcmlog",
                                "--out",
                                in_folder("lat"),
                                NULL};
    if (process_run(&bench, argv) != 0) {
        fail_msg("%s", bench.err);
    }
    assert_int_equal(access(in_folder("lat/latency.html"), R_OK), 0);
    read_text("lat/latency.csv", csv, sizeof csv);
    assert_true(read_count(csv, "pose_to_force_us") > 0); /* of the replay's answers */
    static const char *const gone[] = {"lat/answers.csv", "lat/answers.csv.part"};
    for (int k = 0; k < 2; ++k) {
        assert_int_not_equal(access(in_folder(gone[k]), F_OK), 0);
    }
}

int main(void)
{
    return process_run_tests(make_folder, remove_folder);
}
