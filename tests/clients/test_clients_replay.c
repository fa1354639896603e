/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-replay against a stand-in for the server: answers, silence, ends, damage. */
#include "common/test.h"

#include "stand_in_fixture.h"

SERVED_TEST(lockstep_answers_every_pose_once)
{
    const char *log = in_folder("a.lcmlog");
    const char *csv = in_folder("a.csv");
    const char *record = in_folder("r.lcmlog");
    const char *const argv[] = {"softsim-replay", log,    "--lockstep", "--csv", csv,
                                "--record",       record, "--repeat",   "2",     NULL};
    make_log(log, 150, 2);
    stand_in.lose_pose_every = 101;
    stand_in.lose_answer_every = 200;
    stand_in.sends_rubbish = true;
    run_served(argv, 0);
    assert_int_equal(read_csv(csv), 600);
    assert_int_equal(stand_in.fresh, 600);
    for (int i = 0; i < 600; ++i) {
        const softsim_pose *pose = &stand_in.kept[i];
        assert_int_equal(rows[i].pose_seq, i + 1);
        assert_int_equal(rows[i].probe, i % 2);
        assert_true(rows[i].force[2] == fmax(0.0, -stiffness * pose->position[2]));
        assert_true(rows[i].depth == fmax(0.0, -pose->position[2]));
        assert_true(rows[i].force[0] == 0.0 && rows[i].latency_us >= 0);
        /* a sender of its own, everything that belonged to the old one replaced */
        assert_true(pose->sender == stand_in.kept[0].sender && pose->sender != 123);
        assert_true(pose->seq == i + 1 && pose->force_seq == -1 && pose->flags == 0);
        assert_true(isnan(pose->applied_force[0]) && pose->velocity[0] == 0.125);
        assert_true(i == 0 || pose->utime_us >= stand_in.kept[i - 1].utime_us);
        assert_true(pose->utime_us != 5000000 + 1000 * (i / 2));
    }
    assert_non_null(strstr(child.err, "2 probes"));
    assert_non_null(strstr(child.out, "600 sent, 600 answered, 0 missing"));
    /* What was recorded: every pose, and every force that was for us. */
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *recorded = NULL;
    softsim_log_event event;
    int poses = 0;
    int forces = 0;
    assert_int_equal(softsim_log_open(record, &recorded, &error), SOFTSIM_OK);
    while (softsim_log_next(recorded, &event) == SOFTSIM_LOG_EVENT) {
        softsim_pose pose;
        softsim_force force;
        poses += softsim_log_probe(event.channel) >= 0 &&
                 softsim_log_decode_pose(event.data, event.data_size, &pose);
        forces += strncmp(event.channel, "SOFTSIM_FORCE_", 14) == 0 &&
                  softsim_log_decode_force(event.data, event.data_size, &force) &&
                  force.sender == stand_in.kept[0].sender;
    }
    softsim_log_close(&recorded);
    assert_int_equal(poses, 600);
    assert_true(forces >= 600);
}

/* A machine that holds one of the two back for long loses messages on their way: so many as it
 * says, and no more. Only where the last pose is answered is none still on its way: else it is
 * played again. */
SERVED_TEST(paced_replay_keeps_the_answers)
{
    const char *log = in_folder("a.lcmlog");
    const char *csv = in_folder("a.csv");
    const char *const argv[] = {"softsim-replay", log, "--csv", csv, NULL};
    make_log(log, 400, 1);
    int count = 0, last = 0;
    for (int attempt = 0; attempt < 10 && last != 400; ++attempt) {
        const long before = run_among_rubbish(argv, 400);
        count = read_csv(csv);
        assert_in_range(count, 1, stand_in.fresh);
        last = rows[count - 1].pose_seq;
        assert_true(last < 400 || 400 - count <= count_dropped() - before);
    }
    assert_int_equal(last, 400); /* else it has never waited for the rest */
    double peak = 0.0;
    for (int i = 0, k = 0; i < count; ++i, ++k) {
        while (k < stand_in.fresh && stand_in.kept[k].seq != rows[i].pose_seq) {
            ++k;
        }
        assert_true(k < stand_in.fresh);
        assert_true(rows[i].force[2] == fmax(0.0, -stiffness * stand_in.kept[k].position[2]));
        peak = fmax(peak, rows[i].force[2]);
    }
    char summary[2][64];
    snprintf(summary[0], sizeof summary[0], "400 sent, %d answered, %d missing", count,
             400 - count);
    snprintf(summary[1], sizeof summary[1], "peak %.6g N", peak);
    assert_non_null(strstr(child.out, summary[0]));
    assert_non_null(strstr(child.out, summary[1]));
}

SERVED_TEST(pose_csv_is_replayed)
{
    const char *path = in_folder("p.csv");
    const char *const argv[] = {"softsim-replay", path, "--lockstep", "--rate", "500", NULL};
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(
        "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,3,0,0,0,1,0,0,0,0\n0.1,3,0,0,-0.01,1,0,0,0,1\n",
        file);
    fclose(file);
    run_served(argv, 0);
    assert_int_equal(stand_in.fresh, 51);
    assert_int_equal(stand_in.kept[50].buttons, 1);
    assert_true(stand_in.kept[25].probe == 3 && isnan(stand_in.kept[25].velocity[0]));
    assert_true(fabs(stand_in.kept[25].position[2] + 0.005) < 1e-15);
}

SERVED_TEST(silence_is_a_failure)
{
    const char *log = in_folder("a.lcmlog");
    const char *const argv[] = {"softsim-replay", log, "--lockstep", NULL};
    make_log(log, 10, 1);
    stand_in.is_mute = true;
    run_served(argv, 1);
    assert_non_null(strstr(child.err, "no answer for 5 s after pose 1"));
    assert_in_range(stand_in.poses, 10, 60); /* the pose was sent again and again */
}

/* A replay that is broken off while it records. */
typedef struct recording {
    const char *csv, *csv_part, *record, *record_part, *argv[7];
} recording;

static recording make_recording(void)
{
    const char *log = in_folder("a.lcmlog");
    recording r = {.csv = in_folder("k.csv"),
                   .csv_part = in_folder("k.csv.part"),
                   .record = in_folder("k.lcmlog"),
                   .record_part = in_folder("k.lcmlog.part")};
    const char *const argv[7] = {"softsim-replay", log, "--csv", r.csv, "--record", r.record, NULL};
    memcpy(r.argv, argv, sizeof r.argv);
    make_log(log, 30000, 1);
    return r;
}

/* It left records up to its end, nothing cut and nothing damaged, and no file with its own name. */
/* A kill within a write may leave a part of a record besides. */
static void expect_left(const recording *r, int least, bool is_killed)
{
    int64_t rest = 0;
    assert_true(count_records(r->record_part, &rest) > least);
    assert_in_range(rest, 0, is_killed ? 28 + 16 + SS_WIRE_FORCE_SIZE : 0);
    assert_int_equal(access(r->csv, F_OK), -1);
    assert_int_equal(access(r->record, F_OK), -1);
}

/* A file has its name once it is complete; what there is until then stays, and is named. */
SERVED_TEST(stopped_replay_keeps_its_files)
{
    const recording r = make_recording();
    run_until_stopped(r.argv, SIGINT, 1);
    const char *stopped = strstr(child.err, "stopped after");
    assert_non_null(stopped);
    assert_non_null(strstr(stopped, "k.csv: not complete; what was recorded is in "));
    assert_non_null(strstr(stopped, r.csv_part));
    assert_non_null(strstr(stopped, r.record_part));
    assert_true(read_csv(r.csv_part) > 0);
    expect_left(&r, 0, false);
}

SERVED_TEST(a_killed_replay_leaves_what_it_recorded)
{
    const recording r = make_recording();
    start_server();
    process_start(&child, r.argv, NULL);
    wait_for_file(r.csv_part);
    wait_for_file(r.record_part);
    process_signal(&child, SIGKILL);
    expect_status(128 + SIGKILL);
    stop_server();
    assert_non_null(strstr(child.err, r.csv_part)); /* told while it could */
    assert_non_null(strstr(child.err, r.record_part));
    assert_true(count_lines(r.csv_part, true) > 1);
    expect_left(&r, 10, true);
    /* Nor may what was left be written over by who plays it. */
    const char *const over[] = {"softsim-replay", r.record_part, "--record", r.record, NULL};
    assert_int_equal(process_run(&child, over), 2);
    assert_non_null(strstr(child.err, "k.lcmlog.part', which is the file played"));
}

/* Records are missing: played, and converted, but not complete. */
SERVED_TEST(damaged_logs_are_played_and_named)
{
    const char *log = in_folder("a.lcmlog"), *csv = in_folder("a.csv");
    const char *const argv[] = {"softsim-replay", log, "--lockstep", "--csv", csv, NULL};
    make_log(log, 20, 1);
    FILE *file = fopen(log, "r+b");
    assert_non_null(file);
    const long record = 28 + 11 + SS_WIRE_POSE_SIZE;
    static const unsigned char huge[4] = {0x7F, 0xFF, 0xFF, 0xFF};
    fseek(file, 4 * record + 24, SEEK_SET);
    fwrite(huge, 1, 4, file);
    fclose(file);
    assert_int_equal(truncate(log, 20 * record - 7), 0);
    run_served(argv, 1);
    char expected[128];
    snprintf(expected, sizeof expected, "damaged record at byte %ld, skipped %ld bytes", 4 * record,
             record);
    assert_non_null(strstr(child.err, expected));
    snprintf(expected, sizeof expected, "truncated record at byte %ld", 19 * record);
    assert_non_null(strstr(child.err, expected));
    assert_non_null(strstr(child.err, "records are missing; what is left was played"));
    assert_int_equal(stand_in.fresh, 18);
    assert_int_equal(access(csv, F_OK), -1);
    assert_int_equal(read_csv(in_folder("a.csv.part")), 18);

    const char *out = in_folder("b.lcmlog");
    const char *const convert[] = {"softsim-replay", "--convert", log, out, NULL};
    int64_t rest = 0;
    assert_int_equal(process_run(&child, convert), 1);
    assert_non_null(strstr(child.err, "records are missing; what is left was converted"));
    assert_int_equal(access(out, F_OK), -1);
    assert_int_equal(count_records(in_folder("b.lcmlog.part"), &rest), 18);
}

/* A bit of a record's type: it is no pose any more. A message of another size never was one. */
SERVED_TEST(a_pose_of_another_type_is_damage)
{
    const char *log = in_folder("a.lcmlog"), *out = in_folder("b.lcmlog");
    const char *const argv[] = {"softsim-replay", "--convert", log, out, NULL};
    make_log(log, 20, 1);
    FILE *file = fopen(log, "r+b");
    assert_non_null(file);
    fseek(file, 4 * (28 + 11 + SS_WIRE_POSE_SIZE) + 28 + 11, SEEK_SET);
    fputc('x', file);
    fclose(file);
    assert_int_equal(process_run(&child, argv), 1);
    assert_non_null(strstr(child.err, "is no probe_pose_t"));
    assert_int_equal(access(out, F_OK), -1);

    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    const softsim_pose pose = {.seq = 1, .orientation = {1.0}};
    assert_int_equal(softsim_log_create(log, &writer, &error), SOFTSIM_OK);
    softsim_log_write_pose(writer, 1000, "SOFTSIM_PROBE_0", &pose);
    softsim_log_write(writer, 2000, "ULTRASOUND_PROBE_1", "an image", 9);
    softsim_log_write_pose(writer, 3000, "SOFTSIM_PROBE_0", &pose);
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
    assert_int_equal(process_run(&child, argv), 0);
    assert_non_null(strstr(child.err, "is no probe_pose_t"));
}

/* Nothing tells whose were taken: played, and converted, but not complete. */
SERVED_TEST(poses_of_two_senders_are_played_and_named)
{
    const char *log = in_folder("a.lcmlog"), *out = in_folder("b.lcmlog");
    const char *csv = in_folder("a.csv");
    const char *const argv[] = {"softsim-replay", log, "--lockstep", "--csv", csv, NULL};
    const char *const convert[] = {"softsim-replay", "--convert", log, out, NULL};
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    assert_int_equal(softsim_log_create(log, &writer, &error), SOFTSIM_OK);
    for (int i = 0; i < 20; ++i) {
        const softsim_pose pose = {.sender = 1 + i % 2, .seq = 1 + i / 2, .orientation = {1.0}};
        softsim_log_write_pose(writer, 1000 * i, "SOFTSIM_PROBE_0", &pose);
    }
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
    run_served(argv, 1);
    assert_non_null(strstr(child.err, "poses of two senders on probe 0 at byte "));
    assert_non_null(strstr(child.err, "poses of two senders are mixed; all of them were played"));
    assert_int_equal(access(csv, F_OK), -1);
    assert_int_equal(read_csv(in_folder("a.csv.part")), 20);
    assert_int_equal(process_run(&child, convert), 1);
    assert_non_null(strstr(child.err, "are mixed; all of them were converted"));
    assert_int_equal(access(out, F_OK), -1);
}

/* As a recorder that was killed leaves it, cut anywhere: said, and complete. */
SERVED_TEST(a_log_that_lacks_its_end_is_complete)
{
    const char *log = in_folder("a.lcmlog"), *csv = in_folder("a.csv");
    const char *const argv[] = {"softsim-replay", log, "--lockstep", "--csv", csv, NULL};
    const char *const convert[] = {"softsim-replay", "--convert", log, in_folder("b.lcmlog"), NULL};
    const long record = 28 + 11 + SS_WIRE_POSE_SIZE;
    for (long cut = 1; cut < record; cut += cut < 50 ? 1 : 29) {
        make_log(log, 20, 1);
        assert_int_equal(truncate(log, 19 * record + cut), 0);
        if (process_run(&child, convert) != 0) {
            fail_msg("cut at %ld: %s", cut, child.err);
        }
        assert_non_null(strstr(child.err, "truncated record at byte "));
        assert_null(strstr(child.err, "missing"));
    }
    run_served(argv, 0);
    assert_int_equal(read_csv(csv), 19);
}

SERVED_TEST(conversion_is_reproducible)
{
    const char *path = in_folder("p.csv");
    const char *first = in_folder("1.lcmlog");
    const char *second = in_folder("2.lcmlog");
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,0,0,0,0,1,0,0,0,0\n1,0,1,0,0,1,0,0,0,0\n",
          file);
    fclose(file);
    const char *const once[] = {"softsim-replay", "--convert", path, first, NULL};
    const char *const again[] = {"softsim-replay", "--convert", first, second, NULL};
    assert_int_equal(process_run(&child, once), 0);
    assert_int_equal(process_run(&child, again), 0);
    char command[300];
    snprintf(command, sizeof command, "cmp %s %s", first, second);
    assert_int_equal(system(command), 0);
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_poses *poses = NULL;
    softsim_pose_event event;
    char note[64];
    int count = 0;
    assert_int_equal(softsim_poses_open(first, 1000.0, &poses, &error), SOFTSIM_OK);
    while (softsim_poses_next(poses, &event, note, sizeof note) == SOFTSIM_POSES_POSE) {
        assert_int_equal(event.time_us, 1000 * count);
        assert_true(fabs(event.pose.position[0] - 1e-3 * count) < 1e-15);
        assert_int_equal(event.pose.seq, ++count);
    }
    softsim_poses_close(&poses);
    assert_int_equal(count, 1001);
}

/* Paced: it may be over before five seconds of silence are. */
SERVED_TEST(a_run_without_any_answer_is_a_failure)
{
    const char *log = in_folder("a.lcmlog");
    const char *const argv[] = {"softsim-replay", log, "--speed", "5", NULL};
    make_log(log, 50, 1);
    assert_int_equal(process_run(&child, argv), 1);
    assert_non_null(strstr(child.err, "no answer came; is softsimd running"));
    assert_non_null(strstr(child.out, "50 sent, 0 answered"));
}

/* ---- another sender on the probe ---- */

/* How often `text` holds `word`. */
static int count_words(const char *text, const char *word)
{
    int count = 0;
    for (const char *at = text; (at = strstr(at, word)) != NULL; ++at) {
        ++count;
    }
    return count;
}

/* Nothing of the log is refused, nor is what asks whose the probe is a part of it. Where a machine
 * let no answer through for half a second, the log began without, and is played again. */
SERVED_TEST(a_probe_that_another_sender_holds_is_waited_for)
{
    const char *log = in_folder("a.lcmlog"), *csv = in_folder("a.csv"),
               *record = in_folder("r.lcmlog");
    const char *const argv[] = {"softsim-replay", log,        "--csv", csv, "--record",
                                record,           "--repeat", "2",     NULL};
    make_log(log, 200, 2);
    int runs = 0;
    do {
        assert_true(++runs < 20);
        memset(&stand_in, 0, sizeof stand_in);
        stand_in.held_questions = 7;
        run_served(argv, 0);
    } while (count_words(child.err, "another sender holds probe ") == 0);
    assert_true(stand_in.questions > 7);
    assert_int_equal(count_words(child.err, "another sender holds probe "), 1);
    assert_non_null(strstr(child.err, "; waits until it has let go"));
    assert_null(strstr(child.out, "refused"));
    assert_non_null(strstr(child.out, "800 sent"));
    const int count = read_csv(csv);
    for (int i = 0; i < count; ++i) {
        assert_true(rows[i].pose_seq >= 1 && (rows[i].flags & SOFTSIM_FORCE_OTHER_SENDER) == 0);
    }
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *recorded = NULL;
    softsim_log_event event;
    int poses = 0;
    assert_int_equal(softsim_log_open(record, &recorded, &error), SOFTSIM_OK);
    while (softsim_log_next(recorded, &event) == SOFTSIM_LOG_EVENT) {
        softsim_pose pose;
        if (softsim_log_probe(event.channel) >= 0 &&
            softsim_log_decode_pose(event.data, event.data_size, &pose)) {
            assert_int_equal(pose.seq, ++poses);
        }
    }
    softsim_log_close(&recorded);
    assert_int_equal(poses, 800);
}

/* Where no answer came through for half a second, it is played all the same, and once more. */
SERVED_TEST(a_probe_that_is_never_let_go_is_a_failure)
{
    const char *log = in_folder("a.lcmlog"), *csv = in_folder("a.csv");
    const char *const argv[] = {"softsim-replay", log, "--csv", csv, NULL};
    make_log(log, 50, 1);
    stand_in.held_questions = INT32_MAX;
    start_server();
    int runs = 0;
    do {
        assert_true(++runs < 20);
        stand_in.poses = 0;
        unlink(csv);
        process_run(&child, argv);
    } while (strstr(child.err, "another sender holds probe 0; waits") == NULL);
    assert_int_equal(child.status, 1);
    assert_non_null(strstr(child.err, "another sender still holds probe 0: nothing was played"));
    assert_non_null(strstr(child.out, "0 sent"));
    assert_int_equal(stand_in.poses, 0);
    assert_int_equal(access(csv, F_OK), -1);
    /* Nor is it waited for when nobody wants it. */
    process_start(&child, argv, NULL);
    while (!process_wait_for(&child, "another sender holds probe 0; waits")) {
        process_finish(&child);
        assert_true(++runs < 20);
        process_start(&child, argv, NULL);
    }
    process_signal(&child, SIGINT);
    expect_status(1);
    assert_non_null(strstr(child.err, "stopped after 0 of 50 poses"));
}

/* ---- an end or a change of the server that the summary alone would hide ---- */

/* Ends with 1, says `said`; the answers are under the name of what is not complete. */
static void expect_doubt(const char *said, const char *option)
{
    const char *log = in_folder("a.lcmlog");
    const char *csv = in_folder("a.csv");
    const char *const argv[] = {"softsim-replay", log, "--csv", csv, option, NULL};
    run_served(argv, 1);
    assert_int_equal(access(csv, F_OK), -1);
    assert_true(read_csv(in_folder("a.csv.part")) > 0);
    const char *at = strstr(child.err, said);
    if (at == NULL) {
        fail_msg("no '%s' in: %s", said, child.err);
    }
    assert_null(strstr(at + 1, said)); /* once */
}

/* Its body has not felt the poses before: nothing of it is kept. */
SERVED_TEST(another_server_ends_a_lockstep_replay)
{
    make_log(in_folder("a.lcmlog"), 300, 1);
    stand_in.replaced_from = 100;
    expect_doubt("another server answers since pose 100", "--lockstep");
    assert_int_equal(read_csv(in_folder("a.csv.part")), 99);
    assert_int_equal(stand_in.fresh, 100);
}

/* To its end. Where the machine has held all answers of the other back until then, or lets none
 * through in time, it is played again. */
SERVED_TEST(another_server_is_told_by_a_paced_replay)
{
    const char *log = in_folder("a.lcmlog");
    const char *const argv[] = {"softsim-replay", log, NULL};
    make_log(log, 1500, 1);
    int runs = 0;
    do {
        assert_true(++runs < 20);
        memset(&stand_in, 0, sizeof stand_in);
        stand_in.replaced_from = 500;
        run_served(argv, 1);
        assert_non_null(strstr(child.out, "1500 sent"));
    } while (strstr(child.err, "another server answers since pose ") == NULL);
}

SERVED_TEST(answers_that_stop_before_the_end_are_told)
{
    make_log(in_folder("a.lcmlog"), 1500, 1);
    stand_in.mute_from = 500;
    stand_in.mute_until = INT32_MAX;
    expect_doubt("answers stopped at pose ", NULL);
    assert_non_null(strstr(child.err, " s of 1.499 s)"));
    assert_non_null(strstr(child.out, "1500 sent, "));
}

/* Later than the half second in which last answers come. */
SERVED_TEST(a_late_server_is_waited_for)
{
    const char *log = in_folder("a.lcmlog");
    const char *const argv[] = {"softsim-replay", log, NULL};
    make_log(log, 1500, 1);
    stand_in.mute_from = 900; /* more than a second would be told */
    stand_in.mute_until = INT32_MAX;
    stand_in.is_late = true;
    run_served(argv, 0);
    assert_string_equal(child.err, "");
}

/* A second of them, that is; the log goes on to its end. A server that is held back meanwhile takes
 * the poses faster than they were sent, and its silence is shorter: then it is played again. */
SERVED_TEST(answers_that_are_away_for_long_are_told)
{
    const char *log = in_folder("a.lcmlog"), *csv = in_folder("a.csv");
    const char *const argv[] = {"softsim-replay", log, "--csv", csv, NULL};
    make_log(log, 2500, 1);
    const char *said = NULL;
    for (int runs = 0; said == NULL; ++runs) {
        assert_true(runs < 20);
        memset(&stand_in, 0, sizeof stand_in);
        stand_in.mute_from = 500;
        stand_in.mute_until = 2000;
        start_server();
        const int status = process_run(&child, argv);
        stop_server();
        said = strstr(child.err, "no answer for ");
        assert_true(said == NULL || status == 1);
    }
    double length_s = 0.0;
    int pose = 0;
    assert_int_equal(sscanf(said, "no answer for %lf s from pose %d on", &length_s, &pose), 2);
    assert_true(length_s >= 1.0 && pose >= 400);
    assert_null(strstr(said + 1, "no answer for "));
    assert_non_null(strstr(child.out, "2500 sent"));
    assert_int_equal(access(csv, F_OK), -1);
    assert_true(read_csv(in_folder("a.csv.part")) > 0);
}

/* Those of the other are; what stops in the middle is told by the probe that it was of. */
SERVED_TEST(a_probe_without_any_answer_is_told)
{
    make_log(in_folder("a.lcmlog"), 300, 2);
    stand_in.mute_probe = 1;
    expect_doubt("no answer to any pose of probe 1: has the scene a tool for it?", NULL);
    assert_non_null(strstr(child.out, "600 sent, "));
}

SERVED_TEST(a_probe_whose_answers_stop_is_told)
{
    make_log(in_folder("a.lcmlog"), 1500, 2);
    stand_in.mute_probe = 1;
    stand_in.mute_probe_from = 1000;
    expect_doubt("answers stopped at pose ", NULL);
    assert_non_null(strstr(child.err, " of probe 1 ("));
    assert_non_null(strstr(child.out, "3000 sent, "));
}

/* Two seconds of the log are left at least. */
SERVED_TEST(a_replay_that_was_held_up_is_told)
{
    const char *log = in_folder("a.lcmlog"), *csv = in_folder("a.csv");
    const char *const argv[] = {"softsim-replay", log, "--csv", csv, NULL};
    make_log(log, 3000, 1);
    const char *const said = run_suspended(argv);
    double length_s = 0.0;
    int pose = 0;
    assert_int_equal(
        sscanf(said, "this program was held up for %lf s at pose %d:", &length_s, &pose), 2);
    assert_true(length_s >= 1.0 && pose > 0 && pose <= 3000);
    assert_non_null(strstr(child.out, "3000 sent"));
    assert_int_equal(access(csv, F_OK), -1);
    assert_true(read_csv(in_folder("a.csv.part")) > 0);
}

/* Zero forces that are no tool's in free space: of a body that stands. */
SERVED_TEST(a_model_at_fault_is_told)
{
    make_log(in_folder("a.lcmlog"), 300, 1);
    stand_in.fault_from = 100;
    stand_in.fault_until = INT32_MAX;
    stand_in.tells_state = true;
    expect_doubt("the server's model is at fault from pose 100 on (a number is not finite); 201 "
                 "forces are of it: `softsim-monitor --command reset`",
                 "--lockstep");
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.fault_from = 1; /* and no status says so */
    stand_in.fault_until = 51;
    expect_doubt("the server's model is at fault from pose 1 on; 50 forces are of it: ",
                 "--lockstep");
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.fault_from = 100;
    stand_in.fault_until = INT32_MAX;
    stand_in.tells_state = true;
    expect_doubt("the server's model is at fault from pose ", NULL);
    assert_non_null(strstr(child.err, " on (a number is not finite); "));
}

SERVED_TEST(a_paused_server_is_told)
{
    make_log(in_folder("a.lcmlog"), 300, 1);
    stand_in.pause_from = 60; /* its status follows at 100 */
    stand_in.pause_until = 160;
    stand_in.tells_state = true;
    expect_doubt("the server is paused from pose 60 on; 100 forces are of it: `softsim-monitor "
                 "--command resume`",
                 "--lockstep");
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.pause_from = 230;
    stand_in.pause_until = INT32_MAX;
    stand_in.tells_state = true;
    expect_doubt("the server is paused from pose ", NULL);
}

/* A tool that comes in, or a server that ends, whose statuses say so or not. */
SERVED_TEST(forces_that_ramp_are_no_pause)
{
    const char *log = in_folder("a.lcmlog");
    const char *const argv[] = {"softsim-replay", log, NULL};
    make_log(log, 300, 1);
    for (int i = 0; i < 2; ++i) {
        memset(&stand_in, 0, sizeof stand_in);
        stand_in.is_entering = true;
        stand_in.tells_state = i == 0;
        run_served(argv, 0);
        assert_string_equal(child.err, "");
    }
}

SERVED_TEST(poses_refused_for_another_sender_are_told)
{
    make_log(in_folder("a.lcmlog"), 300, 1);
    stand_in.other_from = 200;
    expect_doubt("another sender held probe 0 at pose 200", "--lockstep");
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.other_until = 50; /* each of them has moved the world's time */
    expect_doubt("another sender held probe 0 at pose 1:", "--lockstep");
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.other_from = 100;
    expect_doubt("another sender held probe 0 at pose ", NULL);
}

/* A lockstep server's count that is heard before the log and no more behind it says nothing. */
SERVED_TEST(ticks_that_nobody_counts_are_told)
{
    static const char said[] = "whose ticks they were is not known";
    const char *log = in_folder("a.lcmlog");
    const char *const argv[] = {"softsim-replay", log, "--lockstep", NULL};
    make_log(log, 300, 1);
    stand_in.counts_until = 300;
    run_served(argv, 0);
    assert_null(strstr(child.err, "ticks"));
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.counts_until = 299;
    expect_doubt(said, "--lockstep");
    /* A signal meanwhile stops no log that is played. */
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.counts_until = 299;
    start_server();
    process_start(&child, argv, NULL);
    while ((stand_in.poses < 300 || stand_in.asked == 0) && !process_has_ended(&child)) {
        poll(NULL, 0, 5);
    }
    process_signal(&child, SIGINT);
    expect_status(1);
    assert_null(strstr(child.err, "stopped after"));
    assert_non_null(strstr(child.err, said));
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
