/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-bench latency as a whole: every program of the chain is started, measured and stopped.
 * How late they are is the machine's affair; that there is a report, and nothing but it, is
 * claimed. */
#include "common/test.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
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

/* The bench alone in a tree of a test's own, by its name there. */
static void copy_bench(const char *name)
{
    char buffer[1 << 16];
    FILE *from = fopen(BIN_DIR "/softsim-bench", "rb"), *to = open_file(name);
    assert_non_null(from);
    size_t size;
    while ((size = fread(buffer, 1, sizeof buffer, from)) > 0) {
        assert_int_equal(fwrite(buffer, 1, size, to), size);
    }
    fclose(from);
    assert_int_equal(fclose(to), 0);
    assert_int_equal(chmod(in_folder(name), 0700), 0);
}

/* Runs it there, where it has nothing to measure; what it says. */
static void run_bench(const char *name, char *out, size_t size)
{
    char command[1024];
    snprintf(command, sizeof command, "cd '%s' && %s latency --seconds 1 2>&1", folder,
             in_folder(name));
    FILE *pipe = popen(command, "re");
    assert_non_null(pipe);
    out[fread(out, 1, size - 1, pipe)] = '\0';
    assert_int_equal(WEXITSTATUS(pclose(pipe)), 2);
}

/* The log that it finds has no poses, which it tells with the path. */
TEST(what_is_bundled_is_found_above_the_program)
{
    static const char *const tree[][2] = {{"a", "a/share/softsim/scenes"},
                                          {"b/build", "b/server/scenes"}};
    static const char *const made[] = {
        "a",       "a/bin",    "a/share",         "a/share/softsim", "b",
        "b/build", "b/server", "b/server/scenes", "b/build/bin",     "a/share/softsim/scenes"};
    char said[2048], name[64];
    for (size_t k = 0; k < sizeof made / sizeof *made; ++k) {
        assert_int_equal(mkdir(in_folder(made[k]), 0700), 0);
    }
    for (int k = 0; k < 2; ++k) {
        snprintf(name, sizeof name, "%s/bin/softsim-bench", tree[k][0]);
        copy_bench(name);
        run_bench(name, said, sizeof said);
        assert_non_null(strstr(said, "--scene: no bundled kidney.yaml here or above this program"));
        assert_non_null(strstr(said, "--poses: no bundled kidney-poke.lcmlog here or above"));
        char file[64], expected[256];
        snprintf(file, sizeof file, "%s/kidney.yaml", tree[k][1]);
        write_text(file, "");
        snprintf(file, sizeof file, "%s/kidney-poke.lcmlog", tree[k][1]);
        write_text(file, "");
        run_bench(name, said, sizeof said);
        snprintf(expected, sizeof expected, "%s: no probe poses", in_folder(file));
        if (strstr(said, expected) == NULL) {
            fail_msg("%s", said);
        }
        assert_null(strstr(said, "bundled"));
    }
}

int main(void)
{
    return process_run_tests(make_folder, remove_folder);
}
