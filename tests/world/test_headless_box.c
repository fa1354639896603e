/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* A broad tool that is held still on soft tissue feels a still force, the same at every rate. */
#include "common/test.h"

#include "common/effort.h"
#include "press_fixture.h"

/* A box of 30 x 30 x 20 mm on a block of 80 x 80 x 40 mm held below, 10 kPa. */
static softsim_world *make_box(double rate_hz)
{
    char text[1024];
    (void)snprintf(text, sizeof text,
                   "softsim: 1\n"
                   "object: {mesh: block.msh, units: mm,\n"
                   "         fixed: [{box_m: [[-1, -1, -1], [1, 1, 0.0001]]}]}\n"
                   "model: {name: fem, youngs_modulus_pa: 10000, poisson_ratio: 0.45,\n"
                   "        density_kg_m3: 1060, mass_damping_per_s: 30}\n"
                   "contact: {tools: [{probe: 0, shape: {box: {size_mm: [30, 30, 20]}}}]}\n"
                   "haptic: {max_force_n: 5}\n"
                   "simulation: {rate_hz: %g}\n",
                   rate_hz);
    return open_scene(write_text("box.yaml", text), NULL, 0);
}

typedef struct held {
    double mean, least, most; /* N, of the last .3 s of 1.2 s */
} held;

/* In half a second to `depth`, and there. */
static held hold(double rate_hz, double depth)
{
    enum { TICKS = 1200, LAST = 300 };
    held out = {.least = INFINITY};
    softsim_world *world = make_box(rate_hz);
    for (int n = 0; n < TICKS; ++n) {
        const double deep = (depth + 0.002) * smooth(n / 500.0) - 0.002;
        const double x[3] = {0.0, 0.0, 0.05 - deep};
        const softsim_pose pose = pose_of(n + 1, x);
        const double force = feel(world, &pose).force[2];
        if (n >= TICKS - LAST) {
            out.mean += force / LAST;
            out.least = fmin(out.least, force);
            out.most = fmax(out.most, force);
        }
    }
    softsim_destroy(&world);
    return out;
}

TEST(a_box_held_on_tissue_is_still)
{
    SKIP_WHERE_REPEATED();
    static const int cells[3] = {9, 9, 5};
    static const double size[3] = {80.0, 80.0, 40.0};
    static const double depths[] = {0.003, 0.001, 0.005};
    write_box_mesh(cells, size);
    for (size_t k = 0; k < FULL_IN_LONG_RUN(sizeof depths / sizeof *depths, 1); ++k) {
        double mean[2];
        for (int i = 0; i < 2; ++i) {
            const double rate_hz = i == 0 ? 1000.0 : 500.0;
            const held one = hold(rate_hz, depths[k]);
            print_message("%g mm at %g Hz: %.4f N, %+.1f .. %+.1f %%\n", 1e3 * depths[k], rate_hz,
                          one.mean, 100.0 * (one.least / one.mean - 1.0),
                          100.0 * (one.most / one.mean - 1.0));
            assert_true(one.most - one.least < 0.02 * one.mean);
            mean[i] = one.mean;
        }
        assert_true(fabs(mean[1] - mean[0]) < 0.02 * mean[0]);
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
