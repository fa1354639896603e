/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The bridge without a network: frames, bus, devices; and what the monitor shows. */
#include "common/test.h"
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bridge.h"
#include "common/folder_fixture.h"
#include "common/number_fixture.h"
#include "devices/script.h"
#include "devices/sim.h"
#include "rt/random.h"
#include "rt/vec.h"
#include "show.h"
#include "status_json.h"

/* ---- frame ---- */

TEST(axes_are_signed_permutations)
{
    static const struct {
        const char *axes;
        double image[3]; /* world position of the device's (1, 2, 3); 0,0,0: refused */
    } cases[] = {
        {"x,y,z", {1, 2, 3}},   {"x,-z,y", {1, -3, 2}}, {"-y,+x,z", {-2, 1, 3}},
        {"z,x,-y", {3, 1, -2}}, {"x,x,z", {0, 0, 0}},   {"x,y", {0, 0, 0}},
        {"x,y,z,", {0, 0, 0}},  {"x y z", {0, 0, 0}},   {"", {0, 0, 0}},
        {"x,y,w", {0, 0, 0}},   {"--x,y,z", {0, 0, 0}}, {"X,Y,Z", {0, 0, 0}},
        {"x,y,z ", {0, 0, 0}},  {"-", {0, 0, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        softsim_error error = {.status = SOFTSIM_OK};
        ss_frame frame;
        const double device[3] = {1, 2, 3};
        double world[3];
        const bool is_good =
            ss_frame_init(&frame, cases[i].axes, "0,0,0", 1.0, 1.0, &error) == SOFTSIM_OK;
        assert_int_equal(is_good, cases[i].image[0] != 0);
        assert_int_equal(error.fault_count, !is_good);
        if (is_good) {
            ss_frame_position(&frame, device, world);
            assert_memory_equal(world, cases[i].image, sizeof world);
        }
    }
    static const char *const offsets[] = {"1,2",     "1,2,3,",  "1,2,x", "",
                                          "nan,0,0", "1e9,0,0", "1 2 3"};
    for (size_t i = 0; i < sizeof offsets / sizeof offsets[0]; ++i) {
        softsim_error error = {.status = SOFTSIM_OK};
        ss_frame frame;
        assert_int_equal(ss_frame_init(&frame, "x,y,z", offsets[i], 1.0, 1.0, &error),
                         SOFTSIM_ERROR_ARGUMENT);
    }
}

TEST(frames_are_consistent)
{
    static const char *const permutations[] = {"x,y,z", "x,z,y", "y,x,z",
                                               "y,z,x", "z,x,y", "z,y,x"};
    uint64_t random = 7;
    for (int i = 0; i < 48; ++i) {
        const char *p = permutations[i / 8];
        char axes[16];
        softsim_error error = {.status = SOFTSIM_OK};
        ss_frame frame;
        snprintf(axes, sizeof axes, "%s%c,%s%c,%s%c", i & 1 ? "-" : "", p[0], i & 2 ? "-" : "",
                 p[2], i & 4 ? "-" : "", p[4]);
        assert_int_equal(ss_frame_init(&frame, axes, "0.1,-0.2,0.3", 2.0, 0.5, &error), SOFTSIM_OK);
        double q[4], at[3], force[3], world[3], turned[3], device_force[3], direct[3], q_world[4];
        for (int k = 0; k < 4; ++k) {
            q[k] = ss_random_unit(&random) - 0.5;
        }
        const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        for (int k = 0; k < 4; ++k) {
            q[k] /= length;
        }
        for (int k = 0; k < 3; ++k) {
            at[k] = ss_random_unit(&random) - 0.5;
            force[k] = ss_random_unit(&random) - 0.5;
        }
        /* The tool's z axis points in the world where the device's tool axis points; its x axis
         * too, unless the frame is a mirror. */
        ss_frame_orientation(&frame, q, q_world);
        for (int axis = 2; axis >= 0; axis -= 2) {
            double unit[3] = {0.0, 0.0, 0.0};
            unit[axis] = 1.0;
            ss_rotate(direct, q, unit);
            ss_frame_force_to_world(&frame, direct, world);
            ss_rotate(turned, q_world, unit);
            const double sign = axis == 0 && frame.is_mirror ? -1.0 : 1.0;
            for (int k = 0; k < 3; ++k) {
                assert_near(turned[k], sign * world[k], 1e-14);
            }
        }
        /* Power is kept up to the scales: f_device . v_device = force_scale / scale f . v */
        ss_frame_velocity(&frame, at, world);
        ss_frame_force_to_device(&frame, force, device_force);
        assert_near(ss_dot3(device_force, at), 0.5 / 2.0 * ss_dot3(force, world), 1e-15);
    }
}

/* ---- bus ---- */

TEST(bus_delays_and_keeps_order)
{
    const ss_bus_config config = {.delay_ms = 2.0, .jitter_ms = 1.0, .outlier = 0.05, .seed = 3};
    ss_bus *bus = ss_bus_create(&config, sizeof(int));
    double sum_ms = 0.0;
    int next = 0;
    enum { COUNT = 20000 };
    for (int i = 0; i < COUNT; ++i) {
        const int64_t now_ns = i * 100000000LL; /* far apart: no queueing */
        int got = -1;
        assert_true(ss_bus_send(bus, now_ns, &i));
        const int64_t due_ns = ss_bus_due(bus);
        assert_true(due_ns >= now_ns + 2000000);
        assert_false(ss_bus_receive(bus, due_ns - 1, &got));
        assert_true(ss_bus_receive(bus, due_ns, &got));
        assert_int_equal(got, i);
        sum_ms += 1e-6 * (double)(due_ns - now_ns);
    }
    /* 2 + 1 + 0.05 x 12.5 ms, three standard errors */
    assert_near(sum_ms / COUNT, 3.625, 3.0 * 3.1 / sqrt(COUNT));
    for (int i = 0; i < 1000; ++i) {
        ss_bus_send(bus, COUNT * 100000000LL + i * 1000000LL, &i);
    }
    int got;
    while (ss_bus_receive(bus, INT64_MAX - 1, &got)) {
        assert_int_equal(got, next++);
    }
    assert_int_equal(next, 1000);
    assert_true(ss_bus_due(bus) == INT64_MAX);
    ss_bus_destroy(&bus);
}

TEST(bus_loses_its_share_and_is_bounded)
{
    const ss_bus_config lossy = {.loss = 0.1, .seed = 9};
    ss_bus *bus = ss_bus_create(&lossy, sizeof(int));
    int lost = 0;
    for (int i = 0; i < 10000; ++i) {
        int got;
        lost += !ss_bus_send(bus, i, &i);
        while (ss_bus_receive(bus, i, &got)) {
        }
    }
    assert_in_range(lost, 900, 1100);
    int kept = 0;
    for (int i = 0; i < 10000; ++i) {
        kept += ss_bus_send(bus, 0, &i);
    }
    assert_in_range(kept, 1000, 4096);
    ss_bus_destroy(&bus);
}

/* ---- simulated device ---- */

/* Runs the bridge against a linear tissue of 500 N/m, two ticks late; rows of its CSV. */
static int run_linear(bool is_correcting, double row[][14])
{
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_sim_config sim = {SS_BODY_MEDIUM, SS_GRIP_MEDIUM, SS_SCRIPT_PRESS, 1, 1e-3};
    ss_frame frame;
    ss_device device;
    static ss_bridge bridge;
    const char *path = in_folder("linear.csv");
    ss_output out;
    assert_int_equal(ss_output_record(&out, path, &error), SOFTSIM_OK);
    fputs(ss_bridge_csv_header, out.file);
    assert_int_equal(ss_frame_init(&frame, "x,y,z", "0,0,0", 1.0, 1.0, &error), SOFTSIM_OK);
    assert_int_equal(ss_sim_create(&sim, &device, &error), SOFTSIM_OK);
    const ss_bridge_config config = {
        .is_correcting = is_correcting, .tick_count = 2000, .csv = &out};
    assert_int_equal(ss_bridge_init(&bridge, &config, &frame, &device, &error), SOFTSIM_OK);
    ss_bridge_run_linear(&bridge, 500.0, 2);
    ss_bridge_fini(&bridge);
    assert_int_equal(ss_output_commit(&out, &error), SOFTSIM_OK);
    FILE *csv = fopen(path, "r");
    assert_non_null(csv);
    char line[1024];
    int count = 0;
    assert_non_null(fgets(line, sizeof line, csv));
    assert_string_equal(line, "tick,x,y,z,vx,vy,vz,qx,qy,qz,fx,fy,fz,energy_in_j\n");
    while (count < 2001 && fgets(line, sizeof line, csv) != NULL) {
        char *at = line;
        for (int k = 0; k < 14; ++k) {
            row[count][k] = strtod(at, &at);
            at += *at == ',';
        }
        assert_true(*at == '\n' && row[count][0] == count);
        ++count;
    }
    fclose(csv);
    return count;
}

TEST(device_meets_the_golden_trajectories)
{
    static const struct {
        bool is_correcting;
        int tick;
        double x, z, vz, fz, energy;
    } golden[] = {
        {false, 300, -8.813059081703534e-06, -1.4828397588406855e-03, -3.9615459047971466e-02,
         0.705, 4.753826449699047e-04},
        {false, 1000, 1.5864715315802944e-02, -2.997519045195684e-03, 3.297218465205668e-03, 1.5,
         2.0919013240455002e-03},
        {false, 1999, 1.9992377072798228e-02, 3.928322825046947e-03, 0.0, 0.0,
         -2.2328857728669052e-04},
        {true, 300, -8.808310299857372e-06, -1.4386691849223269e-03, -3.6887155254844660e-02, 0.72,
         5.174379595193946e-04},
        {true, 1000, 1.5864624333161374e-02, -2.995985449975701e-03, 2.894656372095478e-03, 1.5,
         2.204328552012963e-03},
        {true, 1999, 1.9991786382453358e-02, 3.9271984111761945e-03, 0.0, 0.0,
         -4.900114954307547e-05},
    };
    static double row[2001][14];
    for (int i = 0; i < 6; ++i) {
        assert_int_equal(run_linear(golden[i].is_correcting, row), 2000);
        const double *r = row[golden[i].tick];
        assert_near(r[1], golden[i].x, 1e-9);
        assert_near(r[3], golden[i].z, 1e-9);
        assert_near(r[6], golden[i].vz, 1e-9);
        assert_near(r[12], golden[i].fz, 1e-9);
        assert_near(r[13], golden[i].energy, 1e-9);
    }
}

TEST(free_device_follows_the_hand)
{
    /* Every body, grip and script: at rest after the script the hand's friction and tremor leave
     * at most a millimetre, and no energy is exchanged without force. */
    for (int i = 0; i < 3 * 3 * 5; ++i) {
        softsim_error error = {.status = SOFTSIM_OK};
        const ss_sim_config config = {(ss_sim_body)(i % 3), (ss_sim_grip)(i / 3 % 3),
                                      (ss_sim_script)(i / 9), 1, 1e-3};
        ss_device device;
        ss_device_sample sample;
        const double none[3] = {0.0, 0.0, 0.0};
        bool was_grasped = false;
        assert_int_equal(ss_sim_create(&config, &device, &error), SOFTSIM_OK);
        for (int n = 0; n < 3000; ++n) {
            assert_true(device.read(device.state, &sample));
            assert_true(ss_norm3(sample.true_position) < 0.1);
            for (int k = 0; k < 3; ++k) {
                assert_near(sample.position[k], sample.true_position[k], 15.001e-6);
                assert_near(sample.position[k] / 30e-6, round(sample.position[k] / 30e-6), 1e-9);
            }
            was_grasped = was_grasped || sample.buttons == SOFTSIM_BUTTON_GRASP;
            device.exert(device.state, none);
        }
        assert_int_equal(was_grasped, config.script == SS_SCRIPT_GRASP);
        if (config.script == SS_SCRIPT_PRESS || config.script == SS_SCRIPT_GRASP) {
            device.read(device.state, &sample);
            assert_near(sample.true_position[2], config.script == SS_SCRIPT_PRESS ? 0.004 : 0.010,
                        1.2e-3);
        }
        device.destroy(device.state);
    }
}

TEST(script_device_follows_its_path)
{
    static const char text[] = "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n"
                               "2,3,0,0,0,1,0,0,0,0\n2.1,3,0.1,0,0,1,0,0,0,1\n";
    softsim_error error = {.status = SOFTSIM_OK};
    ss_device device;
    ss_device_sample sample;
    const double pushed[3] = {5.0, 0.0, 0.0};
    write_text("path.csv", text);
    assert_int_equal(ss_script_create(in_folder("path.csv"), 1e-3, &device, &error), SOFTSIM_OK);
    int count = 0;
    while (device.read(device.state, &sample)) {
        assert_near(sample.position[0], 1e-3 * count, 1e-12);
        device.exert(device.state, pushed);
        ++count;
    }
    assert_int_equal(count, 101);
    assert_int_equal(sample.buttons, 1);
    device.destroy(device.state);
    assert_int_equal(ss_script_create(in_folder("none.csv"), 1e-3, &device, &error),
                     SOFTSIM_ERROR_FILE);
}

/* A path says no velocity: the CSV has that of the row to the next. */
TEST(the_csv_of_a_path_is_finite)
{
    static const char text[] = "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n"
                               "2,0,0,0,0.1,1,0,0,0,0\n2.1,0,0.1,0,0.1,1,0,0,0,0\n";
    static ss_bridge bridge;
    softsim_error error = {.status = SOFTSIM_OK};
    ss_device device;
    ss_frame frame;
    char written[1 << 16] = "";
    write_text("path.csv", text);
    FILE *csv = fmemopen(written, sizeof written, "w");
    assert_non_null(csv);
    ss_frame_init(&frame, "x,y,z", "0,0,0", 2.0, 1.0, &error);
    assert_int_equal(ss_script_create(in_folder("path.csv"), 1e-3, &device, &error), SOFTSIM_OK);
    ss_output out = {.file = csv};
    const ss_bridge_config config = {.tick_count = 50, .csv = &out, .program = "test"};
    assert_int_equal(ss_bridge_init(&bridge, &config, &frame, &device, &error), SOFTSIM_OK);
    ss_bridge_run_linear(&bridge, 100.0, 0);
    ss_bridge_fini(&bridge);
    assert_int_equal(fclose(csv), 0);
    int rows = 0;
    for (char *at = written, *line = NULL; (line = strsep(&at, "\n")) != NULL && *line != '\0';) {
        double value[14];
        char *end = line;
        for (int k = 0; k < 14; ++k) {
            value[k] = strtod(end, &end);
            assert_true(isfinite(value[k]));
            end += *end == ',';
        }
        assert_int_equal(*end, '\0');
        assert_near(value[4], 2.0, 1e-9);
        assert_near(value[5], 0.0, 1e-9);
        ++rows;
    }
    assert_true(rows >= 49);
}

/* ---- monitor ---- */

TEST(json_is_well_formed)
{
    static char scene[] = "a \"quoted\" \\ \n \x01 name";
    static char model[] = "fem";
    static char reason[] = "";
    softsim_server_status status = {.scene = scene, .model = model, .reason = reason};
    status.step = INT64_MIN;
    status.uptime_s = 1.5;
    status.stable_step_s = INFINITY;
    status.step_us[1] = NAN;
    status.poses_refused[7] = 3;
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    ss_status_json(out, &status);
    const ss_show_hand hand[SOFTSIM_MAX_PROBES] = {{.is_here = true, .force_n = 1.5}};
    ss_show_line(out, &status, hand);
    ss_show_page(out, &status, hand);
    fclose(out);
    static const char *const says[] = {
        "\"scene\": \"a \\\"quoted\\\" \\\\ \\u000a \\u0001 name\"",
        "\"step\": -9223372036854775808",
        "\"uptime_s\": 1.5,",
        "\"stable_step_s\": null",
        "stable step any\n",
        "\"step_us\": [0, null, 0]",
        "\"poses_refused\": [0, 0, 0, 0, 0, 0, 0, 3]",
        "\"reason\": \"\"}",
    };
    for (size_t k = 0; k < sizeof says / sizeof *says; ++k) {
        assert_non_null(strstr(text, says[k]));
    }
    assert_null(strchr(text, '\x01')); /* nor in the text for people */
    free(text);
}

/* Each line that a field names is a line of the page, and the field is on it. */
TEST(every_field_with_a_line_is_on_the_page)
{
    static const struct {
        const char *name, *line, *text;
    } listed[] = {
#define SCALAR(type, name, line, text)       {#name, line, text},
#define ARRAY(type, name, count, line, text) {#name, line, text},
#define TEXT(name, line)                     {#name, line, ""},
        SOFTSIM_SERVER_STATUS_LIST(SCALAR, ARRAY, TEXT)
#undef SCALAR
#undef ARRAY
#undef TEXT
    };
    softsim_server_status status = {.scene = "", .model = "", .reason = "", .probe_periods = {1}};
    const ss_show_hand hand[SOFTSIM_MAX_PROBES] = {{0}};
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    fputc('\n', out);
    ss_show_page(out, &status, hand);
    assert_int_equal(fclose(out), 0);
    for (size_t i = 0; i < sizeof listed / sizeof *listed; ++i) {
        if (listed[i].line[0] == '\0') {
            continue;
        }
        char start[32];
        snprintf(start, sizeof start, "\n%s ", listed[i].line);
        const char *line = strstr(text, start);
        /* The words after the last value: " MB" of "@M MB". */
        const char *last = strrchr(listed[i].text, '@');
        const char *words = last ? last + 2 : "";
        const char *found = line ? strstr(line + 1, words) : NULL;
        if (found == NULL || found > strchr(line + 1, '\n')) {
            fail_msg("%s: nothing of it on a line \"%s\" of the page", listed[i].name,
                     listed[i].line);
        }
    }
    free(text);
}

static void fill(double *value, int count, double with)
{
    for (int i = 0; i < count; ++i) {
        value[i] = with;
    }
}

/* Whatever a forged status and forged forces say, no figure is longer than a column can be. */
TEST(figures_of_a_stranger_are_bounded)
{
    static const double figure[] = {1e300, -1e300, DBL_MAX, -DBL_MAX, 1e15, DBL_MIN, NAN, INFINITY};
    static char scene[] = "k\x1b\x9b\xc2\x9b.yaml", reason[] = "\xc2\x9bK", model[] = "fem\n";
    for (size_t f = 0; f < sizeof figure / sizeof *figure; ++f) {
        const double x = figure[f];
        softsim_server_status s = {.scene = scene, .model = model, .reason = reason};
        s.seq = s.threads = s.nodes = s.active_nodes = s.elements = s.worst_element = INT32_MAX;
        s.substeps = s.probes = s.verdict = s.fault_bits = INT32_MIN;
        s.step = s.bytes_in_use = s.poses_received = s.poses_superseded = INT64_MIN;
        s.mesh_bytes_sent = s.wire_dropped = s.stiffness_backoffs = INT64_MIN;
        s.uptime_s = s.simulation_rate_hz = s.stable_step_s = s.kinetic_j = s.elastic_j = x;
        s.total_j = s.energy_to_device_j = s.energy_from_device_j = x;
        fill(s.step_us, 3, x);
        fill(s.lateness_us, 4, x);
        fill(s.loop_delay_ms, 2, x);
        fill(s.worst_contact_j, 8, x);
        fill(s.stiffness_limit_n_per_m, 8, x);
        ss_show_hand hand[SOFTSIM_MAX_PROBES];
        for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
            s.probe_periods[p] = s.probe_forces[p] = s.probe_missed[p] = INT64_MIN;
            s.poses_refused[p] = INT64_MIN;
            hand[p] = (ss_show_hand){.is_here = true, .force_n = x, .pressed_m = x};
        }
        char *text = NULL;
        size_t size = 0;
        FILE *out = open_memstream(&text, &size);
        ss_show_line(out, &s, hand);
        ss_show_page(out, &s, hand);
        ss_status_json(out, &s);
        assert_int_equal(fclose(out), 0);
        int digits = 0;
        for (const char *at = text; *at != '\0'; ++at) {
            const unsigned char c = (unsigned char)*at;
            digits = c >= '0' && c <= '9' ? digits + 1 : 0;
            assert_true(digits <= 20); /* an int64_t has 19, %.17g 17 */
            assert_true((c >= ' ' && c < 0x7f) || c == '\n');
        }
        free(text);
    }
}

/* ---- summary ---- */

TEST(the_peak_is_told_as_pressed_or_pulled)
{
    static const struct {
        double force_n, indentation_m;
        bool is_linear;
        const char *line;
    } cases[] = {
        {0.75, 0.004, false, "peak force  0.75 N at 4 mm of indentation\n"},
        {0.517, -0.00837, false, "peak force  0.517 N, pulled 8.37 mm\n"},
        {0.0, 0.0, false, "peak force  0 N\n"},
        {2.0, 0.0, true, "peak force  2 N\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const ss_bridge_summary summary = {.peak_force_n = cases[i].force_n,
                                           .peak_indentation_m = cases[i].indentation_m};
        char *said = NULL;
        size_t size = 0;
        FILE *stream = open_memstream(&said, &size);
        assert_non_null(stream);
        ss_bridge_print_peak(&summary, cases[i].is_linear, stream);
        fclose(stream);
        assert_string_equal(said, cases[i].line);
        free(said);
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
