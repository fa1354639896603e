/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The programs that need no server, on odd but whole command lines: no output is ever an input or
 * another output, whatever it is called; and what is doubtful is told. Pipes, full disks and what
 * is recorded: test_tools_files.c.
 */
#include "common/test.h"

#include <fcntl.h>
#include <glob.h>
#include <math.h>
#include <poll.h>
#include <sys/stat.h>

#include "common/effort.h"
#include "input_fixture.h"
#include "softsim/log.h"

static const char two_tools[] = "softsim: 1\n"
                                "object: {mesh: block.msh, units: m, fixed: [{group: bottom}]}\n"
                                "model: {name: fem, youngs_modulus_pa: 10000, poisson_ratio: 0.3}\n"
                                "contact:\n"
                                "  tools:\n"
                                "    - {probe: 0, shape: {sphere: {radius_mm: 15}}}\n"
                                "    - {probe: 1, shape: {sphere: {radius_mm: 15}}}\n";

#define CASE SOURCE_DIR "/tests/reference/b_cantilever"

TEST(no_output_is_an_input_or_another_output)
{
    static const program_row bad[] = {
        {"softsim-run", "--poses poses.csv --csv poses.csv scene.yaml", "--csv: 'poses.csv'"},
        {"softsim-run", "--poses poses.csv --nodes ./poses.csv scene.yaml", "--nodes: './poses"},
        {"softsim-run", "--poses poses.csv --nodes scene.yaml scene.yaml", "is the scene,"},
        {"softsim-run", "--poses poses.csv --reactions link scene.yaml", "--reactions: 'link'"},
        {"softsim-run", "--poses poses.csv --csv hard scene.yaml", "--csv: 'hard'"},
        {"softsim-run", "--duration 0.01 --nodes block.msh scene.yaml", "a file of the scene"},
        {"softsim-run", "--duration 0.01 --csv one.ele pair.yaml", "a file of the scene"},
        {"softsim-run", "--duration 0.01 --vtk block.msh --every 1 scene.yaml", "--vtk: 'block"},
        {"softsim-run", "--duration 0.01 --vtk a --every 1 --csv a scene.yaml",
         "what --csv writes"},
        {"softsim-run", "--duration 0.01 --csv a --nodes a scene.yaml", "what --csv writes"},
        {"softsim-run", "--duration 0.01 --csv a --reactions ./a scene.yaml", "what --csv writes"},
        {"softsim-replay", "--convert poses.csv poses.csv", "is the file played"},
        {"softsim-replay", "--record poses.csv poses.csv", "--record: 'poses.csv'"},
        {"softsim-replay", "--csv hard poses.csv", "--csv: 'hard'"},
        {"softsim-replay", "--csv a --record a poses.csv", "what --record writes"},
        {"softsim-bridge", "--device script --path poses.csv --csv link", "is the device's file"},
        {"softsim-fit", "--scene scene.yaml --curve curve.csv --out scene.yaml", "is the scene,"},
        {"softsim-fit", "--scene scene.yaml --curve curve.csv --out curve.csv", "is a --curve"},
        {"softsim-fit", "--scene scene.yaml --curve curve.csv --out none/f.yaml",
         "none/f.yaml: No such"},
        {"softsim-fit", "--scene scene.yaml --curve curve.csv --out a --fitted a", "what --out"},
        {"softsim-fit", "--scene scene.yaml --curve curve.csv --out a --fitted block.msh",
         "a file of the scene"},
        {"softsim-fit", "--scene scene.yaml --case case --out case/case.yaml",
         "a file of the case"},
        {"softsim-fit", "--scene scene.yaml --case case --out case/mesh_525.msh",
         "a file of the case"},
        {"softsim-fit", "--scene scene.yaml --case case --out case/reference_u_nh_99.csv",
         "a file of the case"},
        {"softsim-mesh", "tetrahedralize block.msh block.msh --edge 1", "is the surface"},
        {"softsim-mesh", "convert block.msh block.msh", "'block.msh' is the input"},
        {"softsim-bench", "accuracy --compare accuracy.csv --out .", "is a --compare file"},
    };
    char out[8192], expected[8192];
    write_inputs();
    assert_int_equal(run("cp -r " CASE " case", out, sizeof out), 0);
    write_text("one.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n");
    write_text("one.ele", "1 4 0\n0 0 1 2 3\n");
    write_text("pair.yaml",
               "softsim: 1\nobject: {mesh: one.node, units: m, fixed: [{nodes: [0]}]}\n"
               "model: {name: fem, youngs_modulus_pa: 10000, poisson_ratio: 0.3}\n");
    assert_int_equal(symlink("poses.csv", in_folder("link")), 0);
    assert_int_equal(link(in_folder("poses.csv"), in_folder("hard")), 0);
    read_text("block.msh", expected, sizeof expected);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        char command[1024];
        if (!has_program(bad[i].program)) {
            continue;
        }
        (void)snprintf(command, sizeof command, BIN_DIR "/%s %s", bad[i].program, bad[i].options);
        const int status = run(command, out, sizeof out);
        if (status != 2 || strstr(out, bad[i].says) == NULL ||
            strchr(out, '\n') != strrchr(out, '\n')) {
            fail_msg("%s %s: status %d: %s", bad[i].program, bad[i].options, status, out);
        }
        assert_int_not_equal(access(in_folder("a"), F_OK), 0);
        read_text("block.msh", out, sizeof out);
        assert_string_equal(out, expected);
        for (int k = 0; k < INPUT_COUNT; ++k) {
            read_text(inputs[k].name, out, sizeof out);
            assert_string_equal(out, inputs[k].text);
        }
    }
    assert_int_equal(run("diff -r " CASE " case", out, sizeof out), 0);
    read_text("one.ele", out, sizeof out);
    assert_string_equal(out, "1 4 0\n0 0 1 2 3\n");
}

/* Pictures of a run of a picture of a run, in one folder. */
TEST(a_picture_never_replaces_the_mesh)
{
    char out[16384], before[16384];
    assert_int_equal(mkdir(in_folder("pictures"), 0777), 0);
    assert_int_equal(run(TOOL "generate block --points 100 --tetrahedra --units m --out "
                              "pictures/surface_00000002.vtk",
                         out, sizeof out),
                     0);
    write_text("shown.yaml", "softsim: 1\n"
                             "object: {mesh: pictures/surface_00000002.vtk, units: m, "
                             "fixed: [{nodes: [0, 1, 2]}]}\n"
                             "model: {name: fem, youngs_modulus_pa: 10000, poisson_ratio: 0.3}\n");
    read_text("pictures/surface_00000002.vtk", before, sizeof before);
    assert_int_equal(run(BIN_DIR "/softsim-run --duration 0.004 --vtk ./pictures --every 1 "
                                 "shown.yaml",
                         out, sizeof out),
                     1);
    assert_non_null(strstr(out, "--vtk: './pictures/surface_00000002.vtk' is a file of the scene"));
    read_text("pictures/surface_00000002.vtk", out, sizeof out);
    assert_string_equal(out, before);
}

TEST(what_an_option_cannot_do_is_refused)
{
    static const says_row bad[] = {
        {"latency --log felt.csv --out here", "--out: --log runs nothing"},
        {"latency --log felt.csv --seconds 5", "--seconds: --log runs nothing"},
        {"latency --log felt.csv --quick", "--quick: --log runs nothing"},
        {"latency --rate 100", "--rate: only --log"},
        {"latency --contacts 0", "--contacts: only --log"},
    };
    char out[4096], command[512];
    if (!has_program("softsim-bench")) {
        skip();
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        (void)snprintf(command, sizeof command, BIN_DIR "/softsim-bench %s", bad[i].given);
        assert_int_equal(run(command, out, sizeof out), 2);
        if (strstr(out, bad[i].says) == NULL || strchr(out, '\n') != strrchr(out, '\n')) {
            fail_msg("%s: %s", bad[i].given, out);
        }
    }
}

/* What cannot be written is found out before anything is done. */
TEST(an_output_that_cannot_be_opened_starts_nothing)
{
    static const call_row bad[] = {
        {"softsim-run", "--duration 0.01 --csv none/x scene.yaml"},
        {"softsim-run", "--duration 0.01 --reactions none/x scene.yaml"},
        {"softsim-run", "--duration 0.01 --csv good.csv --nodes none/x scene.yaml"},
        {"softsim-run", "--duration 0.01 --vtk none/x --every 1 scene.yaml"},
        {"softsim-replay", "--convert poses.csv none/x"},
        {"softsim-replay", "--csv none/x poses.csv"},
        {"softsim-replay", "--record none/x poses.csv"},
        {"softsim-replay", "--record good.lcmlog --csv none/x poses.csv"},
        {"softsim-bridge", "--device sim --duration 0.1 --csv none/x"},
        {"softsim-fit", "--scene scene.yaml --curve curve.csv --out none/x"},
        {"softsim-fit", "--scene scene.yaml --curve curve.csv --out good.yaml --fitted none/x"},
    };
    char out[4096];
    write_inputs();
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        char command[1024];
        if (!has_program(bad[i].program)) {
            continue;
        }
        (void)snprintf(command, sizeof command, BIN_DIR "/%s %s", bad[i].program, bad[i].options);
        if (run(command, out, sizeof out) != 2 ||
            strstr(out, "none/x: No such file or directory") == NULL ||
            strchr(out, '\n') != strrchr(out, '\n')) {
            fail_msg("%s: %s", command, out);
        }
    }
    glob_t left;
    assert_int_equal(glob(in_folder("good.*"), 0, NULL, &left), GLOB_NOMATCH);
}

/* Half a metre at once, and a probe that has no tool. */
TEST(a_run_says_why_poses_were_refused)
{
    char out[4096];
    write_inputs();
    write_text("refused.csv",
               "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n"
               "0,0,0,0,1,1,0,0,0,0\n0.001,0,0,0,1,1,0,0,0,0\n0.002,0,0,0,1.5,1,0,0,0,0\n"
               "0,3,0,0,1,1,0,0,0,0\n0.002,3,0,0,1,1,0,0,0,0\n");
    assert_int_equal(run(BIN_DIR "/softsim-run --poses refused.csv scene.yaml", out, sizeof out),
                     0);
    if (strstr(out, "4 poses, 3 refused (jump 1, wrong probe 2); peak") == NULL) {
        fail_msg("%s", out);
    }
    assert_int_equal(run(BIN_DIR "/softsim-run --poses poses.csv scene.yaml", out, sizeof out), 0);
    assert_non_null(strstr(out, " poses, 0 refused; peak"));
}

/* The number behind "name": of a JSON object. */
static double json_number(const char *json, const char *name)
{
    char key[64];
    (void)snprintf(key, sizeof key, "\"%s\": ", name);
    const char *at = strstr(json, key);
    assert_non_null(at);
    return strtod(at + strlen(key), NULL);
}

/* What a fem plan counts of contact is little, and none without a tool. */
TEST(the_estimate_says_what_of_it_is_contact)
{
    char out[16384];
    write_inputs();
    assert_int_equal(run(BIN_DIR "/softsimd --explain --json scene.yaml", out, sizeof out), 0);
    const double contact_us = json_number(out, "contact_us");
    assert_true(contact_us > 0.0 && contact_us < json_number(out, "step_us"));
    assert_non_null(strstr(out, "\"threads\": [\"net\", \"simulation\", \"haptic\", \"publish\"]"));
    assert_true(json_number(out, "bytes") > 1000.0);
    assert_int_equal(
        run(BIN_DIR
            "/softsimd --explain --json --set contact.tools=[] --set publish.mesh_rate_hz=0 "
            "scene.yaml",
            out, sizeof out),
        0);
    assert_true(json_number(out, "contact_us") == 0.0);
    assert_non_null(strstr(out, "\"threads\": [\"net\", \"simulation\"]"));
    assert_int_equal(run(BIN_DIR "/softsimd --json scene.yaml", out, sizeof out), 2);
}

/* --check tells what makes a scene that is valid one to regret, and by its status: 0 good, 1 usable
 * with warnings, 2 unusable. */
TEST(what_a_model_doubts_is_told)
{
    static const says_row cases[] = {
        {"model.density_kg_m3=1e-6", ": simulation.max_substeps: "},
        {"object.fixed=[]' --set 'gravity_m_s2=[0, 0, -9.81]", ": object.fixed: "},
        {"model.name=corotational' --set 'model.poisson_ratio=0.49", ": model.poisson_ratio: "},
        {"object.fixed=[{box_m: [[-9, -9, -9], [9, 9, 9]]}]", ": object.fixed: "},
        {"object.fixed=[]", ": object.fixed: "},
        {"haptic.coupling.damping_n_s_per_m=1000", ": haptic.coupling.damping_n_s_per_m: "},
    };
    char out[4096], command[512];
    write_inputs();
    assert_int_equal(run(BIN_DIR "/softsimd --check scene.yaml", out, sizeof out), 1);
    assert_non_null(strstr(out, ": object.mesh: what is felt is a smooth surface"));
    run_tool("generate block --points 700 --tetrahedra --units m --out block.msh");
    assert_int_equal(
        run(BIN_DIR "/softsimd --check --set haptic.max_force_n=2 scene.yaml", out, sizeof out), 0);
    assert_non_null(strstr(out, "scene.yaml: good ("));
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        if (strstr(out, cases[k].says) != NULL) {
            fail_msg("told without cause: %s", out);
        }
    }
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        (void)snprintf(command, sizeof command, BIN_DIR "/softsimd --check --set '%s' scene.yaml",
                       cases[k].given);
        if (run(command, out, sizeof out) != 1 || strstr(out, cases[k].says) == NULL ||
            strstr(out, ": good (") != NULL || strstr(out, ": usable, with ") == NULL) {
            fail_msg("%s: %s", cases[k].given, out);
        }
    }
}

/* --check tells that layer.max_active may bind, with how many particles; not where it cannot. */
TEST(a_cap_on_particles_that_may_bind_is_told)
{
    SKIP_WHERE_REPEATED();
    char out[4096], command[512];
    for (int k = 0; k < 2; ++k) {
        (void)snprintf(command, sizeof command,
                       BIN_DIR "/softsimd --check --set model.layer.max_active=%d " SOURCE_DIR
                               "/server/scenes/hm1-tissue.yaml",
                       k == 0 ? 150 : 600);
        assert_int_equal(run(command, out, sizeof out), 1); /* the tool sinks in, in both */
        assert_true((strstr(out, ": model.layer.max_active: ") != NULL) == (k == 0));
        assert_true((strstr(out, "wakes 127") != NULL) == (k == 0));
    }
}

/* A log of two probes takes a tick for each pose, as in the daemon's lockstep: tools that moved at
 * once move in turn. It is said, and not of a log of one. */
TEST(a_log_of_two_probes_is_told_to_play_slower)
{
    enum { TICKS = 200 };
    char out[8192];
    write_inputs();
    write_text("two.yaml", two_tools);
    for (int probes = 1; probes <= 2; ++probes) {
        softsim_log_writer *writer = NULL;
        softsim_error error = {0};
        assert_int_equal(softsim_log_create(in_folder("two.lcmlog"), &writer, &error), SOFTSIM_OK);
        for (int k = 0; k < TICKS; ++k) {
            const int probe = k % probes;
            const softsim_pose pose = {.probe = probe,
                                       .seq = k + 1,
                                       .sender = 1,
                                       .position = {0.05 * probe - 0.025, 0.0, 0.08},
                                       .orientation = {1.0, 0.0, 0.0, 0.0}};
            softsim_log_write_pose(writer, 1000 * (k / probes), probe ? "S_PROBE_1" : "S_PROBE_0",
                                   &pose);
        }
        assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
        const int status =
            run(BIN_DIR "/softsim-run --poses two.lcmlog --csv two.csv two.yaml", out, sizeof out);
        const bool is_told = strstr(out, "poses of 2 probes") != NULL;
        if (status != 0 || strstr(out, "200 ticks,") == NULL || is_told != (probes == 2)) {
            fail_msg("status %d: %s", status, out);
        }
    }
}

/* softsim-fit with stderr on a terminal; what the terminal shows. */
static void run_fit_on_terminal(char *out, size_t size)
{
    const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    assert_true(terminal >= 0);
    assert_true(grantpt(terminal) == 0 && unlockpt(terminal) == 0);
    const pid_t child = fork();
    if (child == 0) {
        const int end = open(ptsname(terminal), O_RDWR | O_NOCTTY);
        if (end < 0 || dup2(end, STDERR_FILENO) < 0 || chdir(folder) != 0) {
            _exit(127);
        }
        execl(BIN_DIR "/softsim-fit", "softsim-fit", "--scene", "scene.yaml", "--curve",
              "curve.csv", "--at", "900,0,0", "--out", "never.yaml", NULL);
        _exit(127);
    }
    /* Read while it runs, in pieces, and the end held open: what a terminal still holds may go with
     * the last who has it open. A byte of our own comes after all of the child's. */
    const int held = open(ptsname(terminal), O_RDWR | O_NOCTTY);
    assert_true(child > 0 && held >= 0);
    size_t used = 0;
    bool has_ended = false;
    int status = 0;
    while (used + 1 < size && (used == 0 || out[used - 1] != '\a')) {
        struct pollfd readable = {.fd = terminal, .events = POLLIN};
        if (poll(&readable, 1, 50) > 0) {
            const ssize_t more = read(terminal, out + used, size - 1 - used);
            assert_true(more > 0);
            used += (size_t)more;
        }
        if (!has_ended && waitpid(child, &status, WNOHANG) == child) {
            has_ended = true;
            assert_int_equal(write(held, "\a", 1), 1);
        }
    }
    assert_true(has_ended && WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 2);
    close(held);
    out[used] = '\0';
    close(terminal);
}

TEST(a_fit_shows_that_it_works_before_its_first_evaluation)
{
    char out[4096];
    if (!has_program("softsim-fit")) {
        skip();
    }
    write_inputs();
    run_fit_on_terminal(out, sizeof out);
    const char *shown = strstr(out, "softsim-fit: 0 evaluations");
    const char *wiped = strstr(out, "\033[K");
    assert_true(shown != NULL && wiped > shown && strstr(wiped, "off the surface") != NULL);
}

/* Played to nobody, it would end well. */
TEST(a_log_without_poses_is_refused)
{
    char out[4096];
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    write_inputs();
    assert_int_equal(softsim_log_create(in_folder("forces.lcmlog"), &writer, &error), SOFTSIM_OK);
    softsim_log_write_force(writer, 0, "SOFTSIM_FORCE_0", &(softsim_force){.seq = 1});
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
    assert_int_equal(
        run(BIN_DIR "/softsim-run --poses forces.lcmlog --hash scene.yaml", out, sizeof out), 2);
    assert_string_equal(out, "softsim-run: forces.lcmlog: no probe poses: no record on a channel "
                             "..._PROBE_<n>\n");
}

/* Nothing tells whose were taken. */
TEST(a_log_of_two_senders_is_not_complete)
{
    char out[4096];
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    write_inputs();
    assert_int_equal(softsim_log_create(in_folder("two.lcmlog"), &writer, &error), SOFTSIM_OK);
    for (int i = 0; i < 20; ++i) {
        const softsim_pose pose = {.sender = 1 + i % 2, .seq = 1 + i / 2, .orientation = {1.0}};
        softsim_log_write_pose(writer, 1000 * i, "SOFTSIM_PROBE_0", &pose);
    }
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
    assert_int_equal(
        run(BIN_DIR "/softsim-run --poses two.lcmlog --csv hands.csv scene.yaml", out, sizeof out),
        1);
    assert_non_null(strstr(out, "two.lcmlog: poses of two senders are mixed; all of them were"));
    assert_int_equal(access(in_folder("hands.csv"), F_OK), -1);
    assert_int_equal(access(in_folder("hands.csv.part"), F_OK), 0);
}

/* Not endless, and not the default. */
TEST(a_duration_of_nothing_is_refused)
{
    static const char *const started[] = {"softsimd --duration 0 scene.yaml",
                                          "softsim-run --duration 0 scene.yaml",
                                          "softsim-run --duration 0 --poses poses.csv scene.yaml"};
    char out[4096], command[512];
    write_inputs();
    for (int i = 0; i < 3; ++i) {
        (void)snprintf(command, sizeof command, "timeout 900 " BIN_DIR "/%s", started[i]);
        const int status = run(command, out, sizeof out);
        if (status != 2 || strstr(out, "--duration: 0 is out of range") == NULL) {
            fail_msg("%s: status %d: %s", started[i], status, out);
        }
    }
}

/* A press of 10 mm is told as one, beside what the tool is still ahead of the surface. */
TEST(a_press_of_ten_millimetres_reads_as_one)
{
    SKIP_WHERE_REPEATED();
    char out[4096];
    write_inputs();
    write_text("press.yaml",
               "softsim: 1\nobject: {mesh: soft.msh, units: m, fixed: [{group: bottom}]}\n"
               "model: {name: fem, youngs_modulus_pa: 10000, poisson_ratio: 0.45,\n"
               "        density_kg_m3: 1060, mass_damping_per_s: 30}\n"
               "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 8}}}]}\n"
               "haptic: {max_force_n: 20}\n");
    write_text("press.csv", "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,0,0,0,0.030,1,0,0,0,0\n"
                            "0.2,0,0,0,0.028,1,0,0,0,0\n0.7,0,0,0,0.018,1,0,0,0,0\n"
                            "0.9,0,0,0,0.018,1,0,0,0,0\n1.2,0,0,0,0.040,1,0,0,0,0\n");
    assert_int_equal(run(TOOL "generate block --tetrahedra --size-mm 80,80,40 --points 400 --units "
                              "m --out soft.msh && " BIN_DIR
                              "/softsim-run --poses press.csv --csv pressed.csv press.yaml",
                         out, sizeof out),
                     0);
    assert_int_equal(run("grep -m 1 ^850, pressed.csv && tail -1 pressed.csv", out, sizeof out), 0);
    double depth = 0.0, indentation = 0.0, end_depth = 1.0, end = 1.0;
    const char *last = strchr(out, '\n');
    assert_non_null(last);
    assert_int_equal(sscanf(out, "%*d,%*f,%*d,%*f,%*f,%*f,%lf,%*f,%*d,%lf", &depth, &indentation),
                     2);
    assert_int_equal(sscanf(last, "%*d,%*f,%*d,%*f,%*f,%*f,%lf,%*f,%*d,%lf", &end_depth, &end), 2);
    print_message("pressed by 10 mm: depth_m %g, indentation_m %g\n", depth, indentation);
    assert_true(fabs(indentation - 0.010) < 1e-4 && depth < 0.002);
    assert_true(end_depth == 0.0 && end == 0.0);
}

/* Every column of every CSV stands in the --help of the program that writes it. */
TEST(help_explains_every_column)
{
    static const struct {
        const char *program, *columns;
    } written[] = {
        {"softsim-run",
         "step time_s probe fx fy fz depth_m energy_j verdict indentation_m set node "
         "x y z ux uy uz"},
        {"softsim-replay", "pose_seq pose_utime probe fx fy fz tx ty tz depth_m stiffness_n_per_m "
                           "model_age_us flags latency_us indentation_m"},
        {"softsim-bridge",
         "tick x y z vx vy vz qx qy qz fx fy fz energy_in_j time_s probe ow ox oy "
         "oz buttons depth_m indentation_m"},
    };
    char out[16384], command[512], columns[512];
    for (int i = 0; i < 3; ++i) {
        (void)snprintf(command, sizeof command, BIN_DIR "/%s --help", written[i].program);
        assert_int_equal(run(command, out, sizeof out), 0);
        for (char *at = out; *at != '\0'; ++at) { /* "fx,fy,fz" are words too */
            *at = (char)(strchr(",;\n", *at) != NULL ? ' ' : *at);
        }
        (void)snprintf(columns, sizeof columns, "%s", written[i].columns);
        for (char *word = strtok(columns, " "); word != NULL; word = strtok(NULL, " ")) {
            char spaced[64];
            (void)snprintf(spaced, sizeof spaced, " %s ", word);
            if (strstr(out, spaced) == NULL) {
                fail_msg("%s --help does not explain %s", written[i].program, word);
            }
        }
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
