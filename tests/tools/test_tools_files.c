/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The programs that need no server, and what is not a file: pipes, closed descriptors, full disks;
 * what a run that is stopped leaves.
 */
#include "common/test.h"

#include "input_fixture.h"

/* ---- pipes, devices and leftovers ---- */

TEST(a_full_disk_ends_a_run)
{
    char out[4096];
    write_inputs();
    if (access("/dev/full", W_OK) != 0) {
        skip();
    }
    assert_int_equal(run("timeout 900 " BIN_DIR
                         "/softsim-run --duration 1000000 --csv /dev/full scene.yaml",
                         out, sizeof out),
                     1);
    assert_non_null(strstr(out, "/dev/full: cannot write"));
}

/* A shell has opened the file behind /dev/fd/N: it is written there, before what is printed. */
TEST(standard_output_may_be_a_file)
{
    char out[4096], text[4096];
    write_inputs();
    assert_int_equal(run("(" BIN_DIR
                         "/softsim-run --duration 0.002 --csv /dev/fd/1 --hash scene.yaml "
                         "2>err.txt >shown.txt)",
                         out, sizeof out),
                     0);
    read_text("shown.txt", text, sizeof text);
    assert_ptr_equal(strstr(text, "step,time_s,probe"), text);
    const char *last = strstr(text, "\n2,0.002,0,");
    assert_non_null(last);
    assert_int_equal(strlen(strchr(last + 1, '\n')), 18); /* the hash and its line's end */
    assert_int_equal(run(BIN_DIR
                         "/softsim-run --duration 0.002 --csv /dev/fd/3 scene.yaml 3>shown.txt",
                         out, sizeof out),
                     0);
    read_text("shown.txt", text, sizeof text);
    assert_non_null(strstr(text, "\n2,0.002,0,"));
}

TEST(devices_may_be_written_twice)
{
    char out[4096];
    write_inputs();
    assert_int_equal(run(BIN_DIR "/softsim-run --duration 0.01 --csv /dev/null --nodes /dev/null "
                                 "scene.yaml",
                         out, sizeof out),
                     0);
}

/* A pipe without a writer would keep a program waiting without end. */
TEST(a_pipe_is_refused_as_any_input)
{
    static const call_row bad[] = {
        {"softsimd", "pipe"},
        {"softsimd", "piped.yaml"},
        {"softsimd", "data.yaml"},
        {"softsim-run", "--duration 0.01 pipe"},
        {"softsim-run", "--poses pipe scene.yaml"},
        {"softsim-replay", "pipe"},
        {"softsim-replay", "pipe.csv"},
        {"softsim-bridge", "--device script --path pipe"},
        {"softsim-fit", "--scene pipe --curve curve.csv --out o.yaml"},
        {"softsim-fit", "--scene scene.yaml --curve pipe --out o.yaml"},
        {"softsim-mesh", "info pipe"},
        {"softsim-mesh", "check pipe.obj"},
        {"softsim-mesh", "convert pipe o.obj"},
        {"softsim-import", "pipe.obj | cat"},
        {"softsim-bench", "latency --log pipe"},
        {"softsim-bench", "latency --poses pipe"},
        {"softsim-bench", "accuracy --compare pipe --out o"},
        {"softsim-bench", "accuracy --scene pipe --out o"},
    };
    char out[8192], command[512];
    write_inputs();
    write_text("piped.yaml", "softsim: 1\nobject: {mesh: pipe, units: m}\n"
                             "model: {name: fem, youngs_modulus_pa: 10000, poisson_ratio: 0.3}\n");
    write_text("data.yaml", "softsim: 1\nobject: {mesh: block.msh, units: m}\n"
                            "model: {name: fem, youngs_modulus_pa: {file: pipe}, "
                            "poisson_ratio: 0.3}\n");
    assert_int_equal(run("mkfifo pipe pipe.csv pipe.obj", out, sizeof out), 0);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        if (!has_program(bad[i].program)) {
            continue;
        }
        (void)snprintf(command, sizeof command, "{ timeout 900 " BIN_DIR "/%s %s; } </dev/null",
                       bad[i].program, bad[i].options);
        const bool is_piped = strchr(bad[i].options, '|') != NULL; /* it wants no terminal */
        const int status = run(command, out, sizeof out);
        if (status != (is_piped ? 0 : 2) ||
            (strstr(out, "a pipe, not a file") == NULL && strstr(out, "cannot read it") == NULL)) {
            fail_msg("%s %s: status %d: %s", bad[i].program, bad[i].options, status, out);
        }
    }
}

/* Opening one waits for a reader; a device may do something. What a shell has opened is another
 * matter. */
/* By hand too; the other programs put their own name before it. */
TEST(the_importer_says_its_name_and_the_file)
{
    static const struct {
        const char *name, *text, *says;
    } bad[] = {
        {"none.obj", NULL, "softsim-import: none.obj: cannot read it"},
        {"short.obj", "v 0 0 0\nv 0 0\n", "softsim-import: short.obj:2: "},
        {"garbage.ply", "ply\n", "softsim-import: garbage.ply: "},
    };
    char out[4096], command[256];
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        if (bad[i].text != NULL) {
            write_text(bad[i].name, bad[i].text);
        }
        (void)snprintf(command, sizeof command, "(" BIN_DIR "/softsim-import %s >answer)",
                       bad[i].name);
        assert_int_equal(run(command, out, sizeof out), 2);
        if (strstr(out, bad[i].says) != out) {
            fail_msg("%s: %s", bad[i].name, out);
        }
        if (!has_program("softsim-mesh")) {
            continue;
        }
        (void)snprintf(command, sizeof command, BIN_DIR "/softsim-mesh info %s", bad[i].name);
        assert_int_equal(run(command, out, sizeof out), 2);
        assert_null(strstr(out, "softsim-import"));
        assert_non_null(strstr(out, bad[i].name));
    }
}

TEST(a_pipe_is_refused_as_any_output)
{
    static const program_row bad[] = {
        {"softsim-run", "--duration 0.01 --csv pipe scene.yaml", "--csv: 'pipe' is a pipe"},
        {"softsim-run", "--duration 0.01 --reactions pipe scene.yaml", "--reactions: 'pipe' is a"},
        {"softsim-run", "--duration 0.01 --nodes link scene.yaml", "--nodes: 'link' is a pipe"},
        {"softsim-run", "--duration 0.01 --vtk pipe --every 1 scene.yaml", "--vtk: 'pipe' is a"},
        {"softsim-run", "--duration 0.01 --csv /dev/tty scene.yaml", "'/dev/tty' is a device"},
        {"softsim-replay", "--csv pipe poses.csv", "--csv: 'pipe' is a pipe"},
        {"softsim-replay", "--record pipe poses.csv", "--record: 'pipe' is a pipe"},
        {"softsim-replay", "--convert poses.csv pipe", "--convert: 'pipe' is a pipe"},
        {"softsim-bridge", "--device sim --csv pipe", "--csv: 'pipe' is a pipe"},
        {"softsim-fit", "--scene scene.yaml --curve curve.csv --out pipe", "--out: 'pipe' is a"},
        {"softsim-mesh", "tetrahedralize block.msh pipe.msh --edge 1", "'pipe.msh' is a"},
        {"softsim-mesh", "convert block.msh pipe.obj", "OUT: 'pipe.obj' is a pipe"},
        {"softsim-mesh", "generate block --out pipe.msh", "--out: 'pipe.msh' is a pipe"},
        {"softsim-mesh", "generate block --out folder.obj", "'folder.obj' is a folder"},
    };
    char out[8192], command[512];
    write_inputs();
    assert_int_equal(run("rm -f pipe pipe.* link && mkdir -p folder.obj && mkfifo pipe pipe.obj "
                         "pipe.msh && ln -s pipe link",
                         out, sizeof out),
                     0);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        if (!has_program(bad[i].program)) {
            continue;
        }
        (void)snprintf(command, sizeof command, "{ timeout 900 " BIN_DIR "/%s %s; } </dev/null",
                       bad[i].program, bad[i].options);
        const int status = run(command, out, sizeof out);
        if (status != 2 || strstr(out, bad[i].says) == NULL ||
            strchr(out, '\n') != strrchr(out, '\n')) {
            fail_msg("%s %s: status %d: %s", bad[i].program, bad[i].options, status, out);
        }
    }
    /* A pipe of the shell's own is read while it is written. */
    assert_int_equal(run(BIN_DIR "/softsim-run --duration 0.002 --csv /dev/stdout scene.yaml "
                                 "2>/dev/null | tail -1",
                         out, sizeof out),
                     0);
    assert_ptr_equal(strstr(out, "2,0.002,0,"), out);
}

static const char *const programs[] = {"softsimd",       "softsim-run",     "softsim-replay",
                                       "softsim-bridge", "softsim-monitor", "softsim-fit",
                                       "softsim-mesh",   "softsim-import",  "softsim-bench"};
enum { PROGRAM_COUNT = sizeof programs / sizeof *programs };

TEST(help_that_gets_nowhere_is_a_failure)
{
    char out[4096], command[256];
    for (int i = 0; i < PROGRAM_COUNT; ++i) {
        static const char *const asked[] = {"--help", "--version"};
        for (int k = 0; k < 2 && has_program(programs[i]); ++k) {
            (void)snprintf(command, sizeof command, "{ " BIN_DIR "/%s %s >/dev/full; }",
                           programs[i], asked[k]);
            if (run(command, out, sizeof out) != 1 ||
                strstr(out, "cannot write to stdout: No space left on device") == NULL) {
                fail_msg("%s: %s", command, out);
            }
            (void)snprintf(command, sizeof command, "{ " BIN_DIR "/%s %s >&-; }", programs[i],
                           asked[k]);
            if (run(command, out, sizeof out) != 1 ||
                strstr(out, "cannot write to stdout: Bad file descriptor") == NULL) {
                fail_msg("%s: %s", command, out);
            }
        }
    }
}

TEST(a_hash_that_gets_nowhere_is_a_failure)
{
    char out[4096];
    write_inputs();
    assert_int_equal(
        run("{ " BIN_DIR "/softsim-run --duration 0.002 --hash scene.yaml >&-; }", out, sizeof out),
        1);
    assert_non_null(strstr(out, "softsim-run: cannot write to stdout"));
    assert_int_equal(
        run("{ " BIN_DIR "/softsim-run --duration 0.002 scene.yaml >&-; }", out, sizeof out),
        0); /* it has nothing to print there */
}

/* LCM would blame the network for it. */
TEST(too_few_descriptors_are_named)
{
    static const char *const started[] = {"softsim-bridge --device sim --ticks 5",
                                          "softsim-monitor --once", "softsim-replay poses.csv",
                                          "softsimd scene.yaml", "softsim-run --duration 1 k.yaml"};
    char out[4096], command[512];
    write_inputs();
    write_text("k.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write_text("k.yaml", "softsim: 1\nobject: {mesh: k.obj, units: m}\n"
                         "model: {name: mass-spring}\n");
    for (int i = 0; i < 5; ++i) {
        (void)snprintf(command, sizeof command, "{ ulimit -n %d && " BIN_DIR "/%s; }",
                       i == 4 ? 6 : 8, started[i]);
        const int status = run(command, out, sizeof out);
        if ((status != 1 && status != 2) ||
            strstr(out, "too many open files: raise `ulimit -n`") == NULL ||
            strstr(out, "route") != NULL) {
            fail_msg("%s: status %d: %s", command, status, out);
        }
    }
}

/* ---- recordings ---- */

/* What is said has no room: the pipe is full, and who holds its other end does not read. Under the
 * limit a run that waits for it ends by a signal. */
TEST(a_reader_who_stalls_holds_up_no_run)
{
    char out[1024];
    assert_int_equal(run("mkfifo stalled && exec 3<>stalled && "
                         "dd if=/dev/zero of=stalled bs=4096 oflag=nonblock 2>/dev/null; "
                         "rm -f run.csv; timeout 900 " BIN_DIR
                         "/softsim-run --duration 1.2 --csv run.csv --hash scene.yaml 2>stalled; "
                         "status=$?; wc -l <run.csv; exit $status",
                         out, sizeof out),
                     0);
    assert_int_equal(strspn(out, "0123456789abcdef"), 16); /* the hash */
    assert_string_equal(out + 16, "\n1201\n");
}

/* The run that the command breaks off, told in `out`, left NAME.csv and NAME.txt under their
 * partial names: ticks 1, 2, 3 ..., at least `least` rows, each with all its columns, and the last
 * with its end. */
static void expect_rows_left(const char *broken_off, const char *name, int least, char out[4096])
{
    char command[512];
    write_inputs();
    assert_int_equal(run(broken_off, out, 4096), 1);
    (void)snprintf(command, sizeof command, "%s.txt.part", name);
    assert_non_null(strstr(out, command));
    (void)snprintf(command, sizeof command,
                   "test ! -e %s.csv && test ! -e %s.txt && "
                   "awk -F, 'NF != 10 || (NR > 1 && $1 != NR - 1) {bad = 1} "
                   "END {exit bad || NR < %d}' %s.csv.part && "
                   "test -z \"$(tail -c 1 %s.csv.part)\"",
                   name, name, least, name, name);
    char nothing[64];
    assert_int_equal(run(command, nothing, sizeof nothing), 0);
}

TEST(a_full_disk_leaves_the_rows_of_a_run)
{
    char out[4096];
    expect_rows_left("{ ulimit -f 700 && timeout 900 " BIN_DIR "/softsim-run --duration 1000000 "
                     "--csv full.csv --reactions full.txt scene.yaml; }",
                     "full", 1000, out);
    assert_non_null(strstr(out, "what was recorded before is in full.csv.part"));
}

/* A result is written in pieces: the first that finds no room says why, whichever it is. */
TEST(a_full_disk_is_named_by_each_result)
{
    static const program_row full[] = {
        {"softsim-run", "--duration 0.002 --nodes full/nodes.csv large.yaml", "full/nodes.csv"},
        {"softsim-run", "--duration 0.002 --vtk full/vtk --every 1 large.yaml",
         "full/vtk/surface_"},
        {"softsim-mesh", "convert large.msh full/out.vtk", "full/out.vtk"},
    };
    char out[4096], command[1024];
    write_inputs();
    assert_int_equal(run(TOOL "generate block --points 2000 --tetrahedra --units m --out large.msh "
                              "&& sed s/block/large/ scene.yaml >large.yaml && mkdir -p full",
                         out, sizeof out),
                     0);
    if (run("unshare -m true", out, sizeof out) != 0) {
        skip(); /* no file system of one's own is allowed here */
    }
    for (size_t i = 0; i < sizeof full / sizeof *full; ++i) {
        (void)snprintf(command, sizeof command,
                       "unshare -m sh -c 'mount -t tmpfs -o size=24k none full && " BIN_DIR
                       "/%s %s; status=$?; ls full; exit $status'",
                       full[i].program, full[i].options);
        const int status = run(command, out, sizeof out);
        const char *said = strstr(out, full[i].says);
        if (status != 1 || said == NULL || strstr(said, "the disk is full: make room") == NULL ||
            strstr(out, ".tmp") != NULL) {
            fail_msg("%s: status %d: %s", command, status, out);
        }
    }
}

/* It takes room for its results before it works: status 2, as all that is wrong at the start. */
TEST(a_full_disk_is_told_before_a_fit)
{
    static const char *const calls[] = {"--out full.yaml", "--out /dev/null --fitted full.yaml"};
    char out[4096], command[512];
    if (!has_program("softsim-fit")) {
        skip();
    }
    write_inputs();
    for (size_t i = 0; i < sizeof calls / sizeof *calls; ++i) {
        (void)snprintf(command, sizeof command,
                       "{ ulimit -f 0 && timeout 900 " BIN_DIR "/softsim-fit --scene scene.yaml "
                       "--curve curve.csv %s; status=$?; ls full.*; exit $status; }",
                       calls[i]);
        const int status = run(command, out, sizeof out);
        if (status != 2 || strstr(out, "full.yaml: cannot write: ") == NULL ||
            strstr(out, "full.yaml.") != NULL) {
            fail_msg("%s: status %d: %s", command, status, out);
        }
    }
}

/* Stopped as soon as its drafts are there, it takes them along, and its folder of scenes. */
TEST(a_stopped_fit_leaves_nothing)
{
    static const char *const calls[] = {"--curve curve.csv --fitted fitted.csv",
                                        "--case " SOURCE_DIR "/tests/reference/b_cantilever"};
    char out[4096], command[1024];
    if (!has_program("softsim-fit")) {
        skip();
    }
    write_inputs();
    for (size_t i = 0; i < sizeof calls / sizeof *calls; ++i) {
        (void)snprintf(command, sizeof command,
                       "{ mkdir -p scratch && export TMPDIR=\"$PWD/scratch\" && " BIN_DIR
                       "/softsim-fit --scene scene.yaml %s --out fit.yaml & pid=$!; "
                       "while ! ls fit.yaml.*.tmp >seen 2>&1 && kill -0 $pid; do sleep 0.02; done; "
                       "kill -TERM $pid; wait $pid; status=$?; "
                       "echo left:; find . -name 'fit*' -o -path './scratch/*'; exit $status; }",
                       calls[i]);
        const int status = run(command, out, sizeof out);
        if (status != 1 || strstr(out, ": stopped before the end") == NULL ||
            strcmp(strstr(out, "left:"), "left:\n") != 0) {
            fail_msg("%s: status %d: %s", command, status, out);
        }
    }
}

/* Neither a killed shell nor Ctrl-C: the program's own end, which closes and names the files. */
TEST(a_stopped_run_leaves_its_rows)
{
    char out[4096];
    expect_rows_left("{ " BIN_DIR "/softsim-run --duration 1000000 --csv cut.csv "
                     "--reactions cut.txt scene.yaml & pid=$!; "
                     "while ! test -s cut.csv.part && kill -0 $pid; do sleep 0.05; done; "
                     "kill -TERM $pid; wait $pid; }",
                     "cut", 10, out);
    assert_non_null(strstr(out, ", before its end"));
    assert_non_null(strstr(out, "cut.csv: not complete; what was recorded is in cut.csv.part"));
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
