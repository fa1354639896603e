/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-bridge against a stand-in for the server: the loop, buses, silence, ends. */
#include "common/test.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "stand_in_fixture.h"

/* One that has an end of its own, with a server and without. */
SERVED_TEST(a_stopped_bridge_keeps_its_file)
{
    const char *csv = in_folder("s.csv"), *part = in_folder("s.csv.part");
    const char *const served[] = {"softsim-bridge", "--device", "sim",   "--offset-m", "0,0,0",
                                  "--duration",     "1000",     "--csv", csv,          NULL};
    const char *const linear[] = {
        "softsim-bridge", "--device", "sim", "--linear-tissue", "500", "--ticks", "1e9",
        "--csv",          csv,        NULL};
    start_server();
    for (int i = 0; i < 2; ++i) {
        process_start(&child, i == 0 ? served : linear, NULL);
        wait_for_file(part);
        process_signal(&child, SIGTERM);
        expect_status(1);
        const char *ended = strstr(child.err, "ended before its time, after ");
        assert_non_null(ended);
        assert_non_null(strstr(ended, "s.csv: not complete; what was recorded is in "));
        assert_true(count_lines(part, false) > 10);
        assert_int_equal(access(csv, F_OK), -1);
        assert_int_equal(unlink(part), 0);
    }
    stop_server();
}

SERVED_TEST(a_killed_bridge_leaves_what_it_recorded)
{
    const char *csv = in_folder("b.csv"), *part = in_folder("b.csv.part");
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--offset-m",
                                "0,0,0",          "--csv",    csv,   NULL};
    start_server();
    process_start(&child, argv, NULL);
    wait_for_file(part);
    process_signal(&child, SIGKILL);
    expect_status(128 + SIGKILL);
    stop_server();
    assert_non_null(strstr(child.err, part));
    assert_int_equal(access(csv, F_OK), -1);
    const int lines = count_lines(part, true);
    assert_true(lines > 10);
    /* It can be played: as many poses as it has rows. */
    const char *again = in_folder("b.lcmlog");
    const char *const convert[] = {"softsim-replay", "--convert", part, again, NULL};
    assert_int_equal(process_run(&child, convert), 0);
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *converted = NULL;
    softsim_log_event event;
    int poses = 0, kept = 0;
    assert_int_equal(softsim_log_open(again, &converted, &error), SOFTSIM_OK);
    while (softsim_log_next(converted, &event) == SOFTSIM_LOG_EVENT) {
        softsim_pose pose;
        assert_true(softsim_log_decode_pose(event.data, event.data_size, &pose));
        const bool has_come = kept < stand_in.fresh && stand_in.kept[kept].seq == poses + 1;
        for (int i = 0; i < 3 && has_come; ++i) {
            assert_true(fabs(pose.position[i] - stand_in.kept[kept].position[i]) < 1e-12);
        }
        kept += has_come;
        ++poses;
    }
    assert_true(kept > 0);
    assert_int_equal(poses, lines - 1);
    softsim_log_close(&converted);
}

/* SIGHUP, as of a terminal that is closed, is an end like SIGTERM, and one that has no other is
 * complete: its file, a summary. */
SERVED_TEST(a_hangup_ends_in_order)
{
    const char *csv = in_folder("h.csv");
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--offset-m",
                                "0,0,0",          "--csv",    csv,   NULL};
    run_until_stopped(argv, SIGHUP, 0);
    assert_non_null(strstr(child.out, "peak force"));
    assert_true(count_lines(csv, false) > 50);
}

/* Fills a pipe, which has no reader now; its writers wait, from here on. */
static void fill_pipe(int write_end)
{
    static const char blank[256];
    assert_true(fcntl(write_end, F_SETFL, O_NONBLOCK) == 0);
    while (write(write_end, blank, sizeof blank) > 0 || write(write_end, blank, 1) > 0) {
    }
    assert_true(fcntl(write_end, F_SETFL, 0) == 0);
}

/* Until the recording has so many lines. */
static bool wait_for_lines(const char *path, int count)
{
    const double begin_s = process_now_s();
    while (access(path, F_OK) != 0 || count_lines(path, true) < count) {
        if (process_now_s() - begin_s > HANG_S) {
            return false;
        }
        poll(NULL, 0, 20);
    }
    return true;
}

/* A bridge that has no end of its own, and says what it says into `sink`. */
static pid_t start_bridge_into(int sink, const char *csv)
{
    const pid_t bridge = fork();
    if (bridge == 0) {
        (void)dup2(sink, STDERR_FILENO);
        (void)dup2(sink, STDOUT_FILENO);
        execl(BIN_DIR "/softsim-bridge", "softsim-bridge", "--device", "sim", "--offset-m", "0,0,0",
              "--csv", csv, (char *)NULL);
        _exit(127);
    }
    return bridge;
}

/* Stops the server, and waits for two seconds of the bridge's time, in which it tells that. */
static bool outlives_server(const char *part)
{
    const bool has_begun = wait_for_lines(part, 500);
    stop_server();
    return has_begun && wait_for_lines(part, count_lines(part, true) + 2000);
}

/* Of such a bridge. */
static void expect_ordered_end(pid_t bridge, const char *part)
{
    int status = 0;
    assert_int_equal(waitpid(bridge, &status, 0), bridge);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 1);
    assert_true(count_lines(part, false) >= 2500); /* forces were away at its end */
}

/* Nobody reads what it says of the server's end: its loop goes on, with no force. */
SERVED_TEST(a_bridge_does_not_wait_for_who_reads_it)
{
    const char *csv = in_folder("q.csv"), *part = in_folder("q.csv.part");
    int ends[2];
    char sink[4096];
    assert_true(pipe2(ends, O_CLOEXEC) == 0);
    start_server();
    const pid_t bridge = start_bridge_into(ends[1], csv);
    (void)wait_for_lines(part, 500);
    fill_pipe(ends[1]);
    const bool goes_on = outlives_server(part);
    assert_int_equal(kill(bridge, SIGTERM), 0);
    close(ends[1]);
    while (read(ends[0], sink, sizeof sink) > 0) {
    }
    close(ends[0]);
    assert_true(goes_on);
    expect_ordered_end(bridge, part);
}

/* Nor does it die of a reader that has gone. */
SERVED_TEST(a_bridge_outlives_who_reads_it)
{
    const char *csv = in_folder("r.csv"), *part = in_folder("r.csv.part");
    int ends[2];
    assert_true(pipe2(ends, O_CLOEXEC) == 0);
    start_server();
    const pid_t bridge = start_bridge_into(ends[1], csv);
    close(ends[0]);
    close(ends[1]);
    const bool goes_on = outlives_server(part);
    assert_int_equal(kill(bridge, SIGTERM), 0);
    assert_true(goes_on);
    expect_ordered_end(bridge, part);
}

/* With a closed stderr the CSV would be number 2 and take what is said there. */
SERVED_TEST(closed_descriptors_write_into_no_file)
{
    const char *csv = in_folder("c.csv");
    char command[512];
    snprintf(command, sizeof command,
             BIN_DIR
             "/softsim-bridge --device sim --offset-m 0,0,0 --ticks 50 --csv %s 2>&- >/dev/null",
             csv);
    const int status = system(command);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 1); /* no force came */
    assert_int_equal(count_lines(csv, false), 51);
}

static bool close_the_loop(void)
{
    const char *csv = in_folder("b.csv");
    const char *const argv[] = {"softsim-bridge", "--device", "sim",   "--script", "press",
                                "--ticks",        "1500",     "--csv", csv,        "--offset-m",
                                "0.5,0.25,0.001", "--probe",  "1",     NULL};
    (void)run_among_rubbish(argv, 1500);
    assert_true(stand_in.fresh <= 1500);
    bool was_touched = false;
    int32_t last_force_seq = -1, last_seq = 0;
    for (int i = 0; i < stand_in.fresh; ++i) {
        const softsim_pose *pose = &stand_in.kept[i];
        assert_true(pose->seq > last_seq && pose->seq <= 1500);
        last_seq = pose->seq;
        assert_true(pose->probe == 1 && pose->flags == SOFTSIM_POSE_CORRECTS);
        assert_true(fabs(pose->position[1] - 0.25) < 1e-3 && isnan(pose->velocity[0]));
        assert_true(pose->applied_force[2] >= 0.0 && pose->applied_force[2] < 6.0);
        assert_true(pose->force_seq >= last_force_seq || pose->force_seq == -1);
        last_force_seq = pose->force_seq;
        was_touched = was_touched || pose->applied_force[2] > 0.5;
    }
    /* The file's last column is the energy of its own force and motion. */
    FILE *file = fopen(csv, "r");
    assert_non_null(file);
    char line[1024];
    double before[14] = {0.0};
    double energy = 0.0;
    int count = 0, kept = 0;
    assert_non_null(fgets(line, sizeof line, file));
    while (fgets(line, sizeof line, file) != NULL) {
        double row[14];
        char *at = line;
        for (int k = 0; k < 14; ++k) {
            row[k] = strtod(at, &at);
            at += *at == ',';
        }
        if (count > 0) {
            for (int k = 0; k < 3; ++k) {
                energy -= before[10 + k] * (row[1 + k] - before[1 + k]);
            }
            assert_true(fabs(energy - before[13]) < 1e-12);
        }
        assert_true(row[0] == count);
        if (kept < stand_in.fresh && stand_in.kept[kept].seq == count + 1) { /* not lost */
            assert_true(fabs(row[9] - stand_in.kept[kept].position[2]) < 1e-15);
            ++kept;
        }
        memcpy(before, row, sizeof before);
        ++count;
    }
    fclose(file);
    assert_int_equal(count, 1500);
    assert_int_equal(kept, stand_in.fresh);
    return was_touched;
}

/* Forces that come late are let go of, by the contract: on a machine that holds one of the two back
 * the press may be felt only when it is done again. */
SERVED_TEST(bridge_closes_the_loop)
{
    for (int presses = 1; !close_the_loop(); ++presses) {
        assert_true(presses < 20);
    }
}

SERVED_TEST(bridge_models_a_bad_bus)
{
    const char *const argv[] = {"softsim-bridge",
                                "--device",
                                "sim",
                                "--offset-m",
                                "0,0,0",
                                "--ticks",
                                "800",
                                "--delay-ms",
                                "3",
                                "--loss",
                                "0.2",
                                "--jitter-ms",
                                "0.5",
                                "--correct",
                                "off",
                                "--script",
                                "slide",
                                NULL};
    run_served(argv, 0);
    /* A fifth lost each way and counted; the last few are still under way. */
    int forces = 0, lost = 0;
    const char *counts = strstr(child.out, "forces ");
    assert_non_null(counts);
    assert_int_equal(
        sscanf(counts, "forces %d received, %*d poses answered, %d messages", &forces, &lost), 2);
    assert_in_range(stand_in.poses, 101, 720);
    assert_in_range(forces, 1, stand_in.poses);
    assert_in_range(lost, 80, 800 - forces);
    double mean_us = 0.0;
    const char *latency = strstr(child.out, "latency_us  mean ");
    assert_non_null(latency);
    assert_int_equal(sscanf(latency, "latency_us  mean %lf", &mean_us), 1);
    assert_true(mean_us > 6000.0); /* there and back */
    assert_int_equal(stand_in.kept[100].flags, 0);
}

SERVED_TEST(bridge_without_a_server_fails_and_says_so)
{
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--offset-m",
                                "0,0,0",          "--ticks",  "50",  NULL};
    assert_int_equal(process_run(&child, argv), 1);
    assert_non_null(strstr(child.err, "no force came"));
    /* The tissue is not looked for longer than the run is to be. */
    const char *const brief[] = {"softsim-bridge", "--device", "sim", "--duration", "2", NULL};
    assert_int_equal(process_run(&child, brief), 1);
    assert_non_null(strstr(child.err, "the tissue was not found: no server was heard in 2 s; "));
}

SERVED_TEST(bridge_tells_that_forces_stop)
{
    const char *csv = in_folder("b.csv");
    const char *const argv[] = {"softsim-bridge", "--device", "sim",   "--offset-m", "0,0,0",
                                "--ticks",        "2400",     "--csv", csv,          NULL};
    stand_in.mute_from = 300;
    stand_in.mute_until = INT32_MAX;
    run_served(argv, 1);
    double at_s = 0.0;
    const char *said = strstr(child.err, "forces stopped at");
    assert_non_null(said);
    assert_int_equal(sscanf(said, "forces stopped at %lf s", &at_s), 1);
    const double answered_s =
        1e-6 * (double)(stand_in.kept[298].utime_us - stand_in.kept[0].utime_us);
    assert_true(at_s > answered_s - 0.1 && at_s > 0.25);
    assert_int_equal(access(csv, F_OK), -1);
    assert_int_equal(count_lines(in_folder("b.csv.part"), false), 2401);
    assert_null(strstr(child.err, "again"));
}

/* How long forces were away at most before they came again, as the bridge told; -1 where they were
 * away at its end. */
static double longest_away(const char *told)
{
    double longest_s = 0.0;
    const char *stopped = NULL, *again = NULL;
    for (const char *at = told; (at = strstr(at, "forces stopped at")) != NULL; ++at) {
        stopped = at;
    }
    for (const char *at = told; (at = strstr(at, "forces again at")) != NULL; ++at) {
        double away_s = 0.0;
        assert_int_equal(sscanf(at, "forces again at %*f s, after %lf s", &away_s), 1);
        longest_s = fmax(longest_s, away_s);
        again = at;
    }
    assert_true(again == NULL || stopped != NULL);
    return stopped != NULL && (again == NULL || stopped > again) ? -1.0 : longest_s;
}

/* The same of a bridge whose server leaves out so many poses. It exits 1 where that was a second or
 * longer, and what it recorded is not complete then. A machine that holds the server back may add
 * pauses of its own; one at the end says nothing of this. */
static double stop_forces(int count)
{
    const char *csv = in_folder("b.csv"), *part = in_folder("b.csv.part");
    const char *const argv[] = {"softsim-bridge", "--device", "sim",   "--offset-m", "0,0,0",
                                "--ticks",        "2400",     "--csv", csv,          NULL};
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.mute_from = 300;
    stand_in.mute_until = 300 + count;
    unlink(csv);
    start_server();
    const int status = process_run(&child, argv);
    stop_server();
    const double away_s = longest_away(child.err);
    if ((away_s >= 0.0 && away_s < 0.95) || away_s > 1.05) { /* as it is rounded */
        assert_int_equal(status, away_s > 1.0);
        assert_int_equal(access(csv, F_OK), away_s > 1.0 ? -1 : 0);
        assert_int_equal(count_lines(away_s > 1.0 ? part : csv, false), 2401);
    }
    return away_s;
}

/* A server that is held back meanwhile takes poses faster than they were sent: then its silence is
 * shorter, and it is asked again. */
SERVED_TEST(bridge_tells_that_forces_come_again)
{
    for (int runs = 0; stop_forces(500) < 0.4; ++runs) {
        assert_true(runs < 20);
    }
    for (int runs = 0; stop_forces(1400) < 1.1; ++runs) {
        assert_true(runs < 20);
    }
}

/* The forces that lay unread meanwhile come at once, so that none seem to have been away. */
SERVED_TEST(a_bridge_that_was_held_up_is_told)
{
    const char *const csv = in_folder("b.csv");
    const char *const argv[] = {"softsim-bridge", "--device", "sim",   "--script", "press",
                                "--ticks",        "3000",     "--csv", csv,        "--offset-m",
                                "0.5,0.25,0.001", NULL};
    const char *const said = run_suspended(argv);
    double length_s = 0.0;
    assert_int_equal(sscanf(said, "this program was held up for %lf s at ", &length_s), 1);
    assert_true(length_s >= 1.0);
    assert_int_equal(access(csv, F_OK), -1);
    assert_int_equal(count_lines(in_folder("b.csv.part"), false), 3001);
}

/* It goes on, but what it keeps is not of one body: told once, exit 1, and no file of that name.
 * Where the machine lets no answer of the other through in time, it is asked again. */
SERVED_TEST(bridge_tells_that_another_server_answers)
{
    const char *csv = in_folder("b.csv"), *part = in_folder("b.csv.part");
    const char *const argv[] = {"softsim-bridge", "--device", "sim",   "--offset-m", "0,0,0",
                                "--ticks",        "1500",     "--csv", csv,          NULL};
    const char *said = NULL;
    double at_s = 0.0;
    for (int runs = 0; said == NULL; ++runs) {
        assert_true(runs < 20);
        memset(&stand_in, 0, sizeof stand_in);
        stand_in.replaced_from = 300;
        run_served(argv, 1);
        said = strstr(child.err, "another server answers since ");
    }
    assert_int_equal(sscanf(said, "another server answers since %lf s", &at_s), 1);
    assert_true(at_s >= 0.3);
    assert_null(strstr(said + 1, "another server answers"));
    assert_non_null(strstr(child.out, "ticks       1500,"));
    assert_non_null(strstr(child.err, "b.csv: not complete; what was recorded is in "));
    assert_int_equal(access(csv, F_OK), -1);
    assert_int_equal(count_lines(part, false), 1501);
}

/* N: the largest that a file of the bridge tells. */
static double largest_force(const char *path)
{
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    char line[2048];
    double largest = 0.0, force[3];
    assert_non_null(fgets(line, sizeof line, file)); /* its header */
    while (fgets(line, sizeof line, file) != NULL) {
        char *at = line;
        for (int k = 0; k < 13; ++k) {
            force[k % 3] = strtod(at, &at); /* columns 10 to 12 are left: 1, 2, 0 */
            at += *at == ',';
        }
        largest = fmax(largest, ss_norm3(force));
    }
    fclose(file);
    return largest;
}

/* A stranger answers every pose before the server does, or the first alone: 10 kN. The device would
 * exert 20. */
SERVED_TEST(who_answers_before_the_server_is_not_felt)
{
    static const int until[] = {INT32_MAX, 2};
    const char *csv = in_folder("b.csv"), *part = in_folder("b.csv.part");
    const char *const argv[] = {"softsim-bridge", "--device", "sim",   "--offset-m", "0,0,0",
                                "--ticks",        "1000",     "--csv", csv,          NULL};
    for (size_t i = 0; i < sizeof until / sizeof *until; ++i) {
        memset(&stand_in, 0, sizeof stand_in);
        stand_in.raced_until = until[i];
        run_served(argv, 1);
        const double largest = largest_force(part);
        print_message("%d: %.4g N\n%s", until[i], largest, child.err);
        assert_true(largest < 0.015 * stiffness); /* 15 mm, deeper than it presses */
        assert_int_equal(access(csv, F_OK), -1);
        assert_int_equal(unlink(part), 0);
    }
}

/* It goes on, since the hand may wait for a reset, and blames no place that the tool was at. */
static void expect_halt(const char *said, const char *cure)
{
    const char *csv = in_folder("b.csv"), *part = in_folder("b.csv.part");
    const char *const argv[] = {"softsim-bridge", "--device", "sim",   "--offset-m", "0,0,0.1",
                                "--ticks",        "1000",     "--csv", csv,          NULL};
    stand_in.tells_state = true;
    run_served(argv, 1);
    const char *at = strstr(child.err, said);
    if (at == NULL || strstr(at + 1, said) != NULL) {
        fail_msg("not once '%s' in: %s", said, child.err);
    }
    assert_non_null(strstr(at, cure));
    assert_null(strstr(child.err, "touched nothing"));
    assert_null(strstr(child.err, "inside"));
    const char *summary = strstr(child.out, "halt        the server");
    assert_non_null(summary);
    assert_non_null(strstr(summary, cure));
    assert_non_null(strstr(child.out, "ticks       1000,"));
    assert_int_equal(access(csv, F_OK), -1);
    assert_int_equal(count_lines(part, false), 1001);
}

SERVED_TEST(bridge_tells_that_the_model_is_at_fault)
{
    stand_in.fault_from = 1;
    stand_in.fault_until = INT32_MAX;
    expect_halt("the server's model is at fault ", "`softsim-monitor --command reset`");
    assert_non_null(strstr(child.err, " (a number is not finite)"));
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.fault_from = 300;
    stand_in.fault_until = 600;
    expect_halt("the server's model is at fault ", "`softsim-monitor --command reset`");
}

SERVED_TEST(bridge_tells_that_the_server_is_paused)
{
    stand_in.pause_from = 1;
    stand_in.pause_until = INT32_MAX;
    expect_halt("the server is paused", "`softsim-monitor --command resume`");
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.pause_from = 300;
    stand_in.pause_until = INT32_MAX;
    expect_halt("the server is paused", "`softsim-monitor --command resume`");
}

/* Statuses come from anybody: those of who sends no forces neither let go of the hand nor are
 * believed. */
SERVED_TEST(bridge_takes_no_status_of_others)
{
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--offset-m",
                                "0,0,0",          "--ticks",  "800", NULL};
    stand_in.tells_state = stand_in.is_state_foreign = true;
    run_served(argv, 0);
    assert_null(strstr(child.err, "two servers"));
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.tells_state = stand_in.is_state_foreign = true;
    stand_in.fault_from = 300;
    stand_in.fault_until = INT32_MAX;
    run_served(argv, 1);
    assert_non_null(strstr(child.err, "the server's model is at fault "));
    assert_null(strstr(child.err, "a number is not finite"));
}

/* What another sends beside the server, but no answer to a pose, keeps nothing from the hand. Where
 * the machine lets the server's answers come late, it presses again. */
SERVED_TEST(scenes_of_another_leave_the_force)
{
    const char *csv = in_folder("b.csv"), *part = in_folder("b.csv.part");
    const char *const argv[] = {"softsim-bridge", "--device", "sim",   "--offset-m", "0,0,0",
                                "--ticks",        "1500",     "--csv", csv,          NULL};
    double largest = 0.0;
    for (int runs = 0; largest < 0.5; ++runs) {
        assert_true(runs < 20);
        memset(&stand_in, 0, sizeof stand_in);
        stand_in.sends_scenes_beside = true;
        start_server();
        const int status = process_run(&child, argv);
        stop_server();
        largest = largest_force(status == 0 ? csv : part);
    }
}

/* One answer of another, and nothing is felt for two seconds: told once, exit 1, and no file of
 * that name. Where the machine holds back what tells it, it is asked again. */
SERVED_TEST(bridge_tells_that_nothing_is_felt)
{
    const char *csv = in_folder("b.csv"), *part = in_folder("b.csv.part");
    const char *const argv[] = {"softsim-bridge", "--device", "sim",   "--offset-m", "0,0,0",
                                "--ticks",        "1500",     "--csv", csv,          NULL};
    const char *said = NULL;
    for (int runs = 0; said == NULL; ++runs) {
        assert_true(runs < 20);
        memset(&stand_in, 0, sizeof stand_in);
        stand_in.beside_at = 5;
        start_server();
        const int status = process_run(&child, argv);
        stop_server();
        said = strstr(child.err, "nothing is felt: another server answers too");
        if (said != NULL) {
            assert_int_equal(status, 1);
            assert_null(strstr(said + 1, "nothing is felt"));
            assert_null(strstr(child.err, "touched nothing"));
            assert_int_equal(access(csv, F_OK), -1);
            assert_int_equal(count_lines(part, false), 1501);
        }
    }
}

SERVED_TEST(bridge_tells_whose_the_probe_is)
{
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--offset-m",
                                "0,0,0",          "--ticks",  "800", NULL};
    stand_in.other_until = 400;
    stand_in.is_entering = true; /* not by its own doing: no hint */
    run_served(argv, 0);
    int forces = 0, answered = 0;
    const char *at = strstr(child.out, "forces ");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "forces %d received, %d poses", &forces, &answered), 2);
    assert_in_range(forces, 1, stand_in.fresh - 399); /* the others are not forces of ours */
    assert_int_equal(answered, forces);
    double held_s = 0.0;
    at = strstr(child.out, "another sender held it for");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "another sender held it for %lf s", &held_s), 1);
    assert_true(held_s > 0.35);
    assert_null(strstr(child.err, "inside"));

    memset(&stand_in, 0, sizeof stand_in);
    stand_in.other_until = INT32_MAX;
    start_server();
    process_start(&child, argv, NULL);
    expect_status(1);
    assert_non_null(strstr(child.err, "no force came: another sender held the probe for"));
}

SERVED_TEST(bridge_tells_that_it_began_inside)
{
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--offset-m",
                                "0,0,0",          "--ticks",  "300", NULL};
    stand_in.is_entering = true;
    run_served(argv, 0);
    assert_non_null(strstr(child.err, "the hand started inside the tissue"));
    memset(&stand_in, 0, sizeof stand_in);
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    assert_null(strstr(child.err, "inside"));
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
