/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A block whose upper part is cut through but for one node, or one edge, of its top: there the skin
 * touches itself. Every model of volumes loads it, and a tool that is pressed beside the pinch,
 * slides over it and is grasped on it gets a finite force without a step: its change from tick to
 * tick is no more than on the whole block along the same path, by a factor for the softer place,
 * and at half the period it is about half.
 */
#include "common/test.h"

#include "common/effort.h"
#include "press_fixture.h"
#include "rt/vec.h"

/* ---- the block ---- */

enum { X = 10, Y = 6, Z = 4, PLANE = 5, MIDDLE = 3 }; /* cells; the cut, and the pinch's place */
static const double edge_mm = 6.0;

typedef enum pinch { WHOLE, AT_NODE, AT_EDGE, PINCHES } pinch;
static const char *const pinch_names[] = {"whole", "node", "edge"};

/* Tetrahedra of the cut plane's nodes go, but for those that have only the pinch's of them. Below
 * the lowest layer nothing is cut, so that the body is one. */
static bool is_kept(pinch kind, const int at[4][3])
{
    for (int k = 0; k < 4; ++k) {
        const bool is_cut = at[k][0] == PLANE && at[k][2] > Z - 2;
        const bool is_pinch =
            at[k][2] == Z && (at[k][1] == MIDDLE || (kind == AT_EDGE && at[k][1] == MIDDLE + 1));
        if (kind != WHOLE && is_cut && !is_pinch) {
            return false;
        }
    }
    return true;
}

static void write_pinched(pinch kind)
{
    static const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    static char elements[256 * 1024];
    static const int cells[3] = {X, Y, Z};
    enum { NODES = (X + 1) * (Y + 1) * (Z + 1) };
    bool has_element[NODES + 1] = {false}; /* by number, from 1 */
    int count = 0, used = 0, nodes = 0;
    for (int cell = 0; cell < X * Y * Z; ++cell) {
        for (int p = 0; p < 6; ++p) {
            int at[4][3] = {{cell % X, cell / X % Y, cell / X / Y}};
            for (int s = 0; s < 3; ++s) {
                memcpy(at[s + 1], at[s], sizeof at[s]);
                ++at[s + 1][order[p][s]];
            }
            if (is_kept(kind, (const int(*)[3])at)) {
                const int odd = p >= 3;
                for (int k = 0; k < 4; ++k) {
                    nodes += !has_element[box_node(cells, at[k])];
                    has_element[box_node(cells, at[k])] = true;
                }
                used += snprintf(elements + used, sizeof elements - (size_t)used,
                                 "%d 4 0 %d %d %d %d\n", ++count, box_node(cells, at[0]),
                                 box_node(cells, at[1 + odd]), box_node(cells, at[2 - odd]),
                                 box_node(cells, at[3]));
            }
        }
    }
    FILE *file = open_file("block.msh");
    fprintf(file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", nodes);
    for (int n = 0; n < NODES; ++n) {
        const int at[3] = {n % (X + 1), n / (X + 1) % (Y + 1), n / (X + 1) / (Y + 1)};
        if (!has_element[box_node(cells, at)]) {
            continue;
        }
        fprintf(file, "%d %g %g %g\n", box_node(cells, at), edge_mm * (at[0] - PLANE),
                edge_mm * (at[1] - MIDDLE), edge_mm * at[2]);
    }
    fprintf(file, "$EndNodes\n$Elements\n%d\n%s$EndElements\n", count, elements);
    assert_int_equal(fclose(file), 0);
}

/* ---- the models ---- */

#define ELASTIC_OF(name) "  name: " name "\n" ELASTIC
static const body models[] = {
    {.name = "fem", .model = ELASTIC_OF("fem")},
    {.name = "fem-quadratic", .model = ELASTIC_OF("fem-quadratic")},
    {.name = "hybrid",
     .model = ELASTIC_OF("hybrid") "  layer: {spacing_m: 0.003, thickness_m: -0.010}\n"},
    {.name = "xpbd", .model = ELASTIC_OF("xpbd")},
    {.name = "corotational", .model = ELASTIC_OF("corotational")},
    {.name = "mass-spring",
     .model = "  name: mass-spring\n  youngs_modulus_pa: 60000\n  density_kg_m3: 1060\n"
              "  mass_damping_per_s: 30\n"},
    {.name = "cnn-energy volume",
     .model = "  name: cnn-energy\n  domain: volume\n  modulus_pa: 400000\n  density_kg_m3: 1060\n"
              "  damping_n_s_per_m4: 100000\n  rest_stiffness_n_per_m4: 3.0e+7\n"},
    {.name = "cnn-energy",
     .model = "  name: cnn-energy\n  modulus_n_per_m: 2000\n  area_density_kg_m2: 11.5\n"
              "  damping_n_s_per_m3: 1725\n  rest_stiffness_n_per_m3: 5.0e+4\n"},
    {.name = "cnn-chainmail", .model = "  name: cnn-chainmail\n"},
    {.name = "chainmail", .model = "  name: chainmail\n  alpha: 0.05\n  beta: 0.05\n"},
};
enum { MODELS = sizeof models / sizeof *models };

/* ---- the path ---- */

/* s: down beside the pinch, over it, on it for a grasp, a little aside, and back. */
static const double down_s = 0.08, over_s = 0.32, grasp_s = 0.40, aside_s = 0.50, end_s = 0.55;
static const double radius_m = 0.008, depth_m = 0.003, way_m = 0.012;

static void path(double t, double out[3])
{
    const double down = smooth(t / down_s);
    const double over = smooth((t - down_s) / (over_s - down_s));
    const double back = smooth((t - over_s) / (grasp_s - over_s));
    const double aside = smooth((t - grasp_s) / (aside_s - grasp_s));
    out[0] = way_m * (-1.0 + 2.0 * over - back + 0.2 * aside);
    out[1] = 0.0005;
    out[2] = 1e-3 * edge_mm * Z + radius_m + 0.001 - (depth_m + 0.001) * down;
}

/* Held below the middle, where hybrid has nodes of its core. */
static softsim_world *open_model(const body *b, double rate_hz)
{
    char text[1024];
    (void)snprintf(text, sizeof text,
                   "softsim: 1\n"
                   "object:\n  mesh: block.msh\n  units: mm\n"
                   "  fixed: [{box_m: [[-1, -1, -1], [1, 1, 0.0121]]}]\n"
                   "model:\n%s"
                   "contact:\n  tools: [{probe: 0, shape: {sphere: {radius_mm: %g}}}]\n"
                   "  working_force_n: 2\n"
                   "haptic: {rate_hz: %g}\n",
                   b->model, 1e3 * radius_m, rate_hz);
    return open_scene(write_text("pinch.yaml", text), NULL, 0);
}

typedef struct felt {
    double most, change, at; /* N; N from tick to tick, at that time (s) */
} felt;

static felt run(const body *b, double rate_hz)
{
    softsim_world *world = open_model(b, rate_hz);
    felt out = {0};
    double last[3] = {0.0};
    softsim_force force = {.seq = -1};
    for (int n = 0; n < (int)(end_s * rate_hz); ++n) {
        double x[3], by[3];
        const double t = n / rate_hz;
        path(t, x);
        softsim_pose pose = pose_of(n + 1, x);
        pose.force_seq = force.seq;
        pose.buttons = t > grasp_s ? SOFTSIM_BUTTON_GRASP : 0;
        force = feel(world, &pose);
        assert_true(ss_is_finite(force.force, 3) && ss_is_finite(force.model_force, 3));
        ss_sub3(by, force.force, last);
        ss_copy3(last, force.force);
        out.most = fmax(out.most, ss_norm3(last));
        if (ss_norm3(by) > out.change) {
            out.change = ss_norm3(by);
            out.at = t;
        }
    }
    softsim_destroy(&world);
    return out;
}

/* A step does not shrink with the period; what moves on does. */
static bool has_step(const felt *at_rate, const felt *at_double)
{
    return at_double->change > 0.7 * at_rate->change;
}

static bool is_smooth(const body *b, pinch kind)
{
    write_pinched(kind);
    const felt one = run(b, 1000.0), half = run(b, 2000.0);
    bool is_good = one.most > 0.05 && !has_step(&one, &half);
    double whole = 0.0;
    if (!is_good) { /* is it the model's own, on any body? */
        write_pinched(WHOLE);
        whole = run(b, 1000.0).change;
        is_good = one.most > 0.05 && one.change <= 1.5 * whole;
    }
    print_message("%-14s %s: up to %.3f N, by %.4f N a tick (at %.3f s), by %.4f at half the "
                  "period; whole block %.4f%s\n",
                  b->name, pinch_names[kind], one.most, one.change, one.at, half.change, whole,
                  is_good ? "" : ": BAD");
    return is_good;
}

TEST(a_slide_and_a_grasp_over_a_pinch_have_no_step)
{
    int bad = 0;
    for (int m = 0; m < MODELS; ++m) {
        bad += FULL_IN_RELEASE(true, false) && !is_smooth(&models[m], AT_NODE);
        bad += !is_smooth(&models[m], AT_EDGE);
    }
    assert_int_equal(bad, 0);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
