/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* contact_force_t.depth of a tool that is driven through a body and far beyond it, and of one that
 * stays deep inside: never more than the body is thick. */
#include "common/test.h"

#include <stdlib.h>

#include "common/effort.h"
#include "press_fixture.h"

/* The body's least extent along an axis, at rest. */
static double thickness_of(softsim_world *world)
{
    softsim_state s;
    softsim_read(world, &s);
    double(*x)[3] = calloc((size_t)s.node_count, sizeof *x);
    double(*u)[3] = calloc((size_t)s.node_count, sizeof *u);
    double least = INFINITY;
    assert_true(x != NULL && u != NULL);
    softsim_read_nodes(world, x, u, NULL);
    for (int a = 0; a < 3; ++a) {
        double low = INFINITY, high = -INFINITY;
        for (int32_t i = 0; i < s.node_count; ++i) {
            low = fmin(low, x[i][a] - u[i][a]);
            high = fmax(high, x[i][a] - u[i][a]);
        }
        least = fmin(least, high - low);
    }
    free(x);
    free(u);
    return least;
}

TEST(depth_is_bounded_by_the_body)
{
    /* Of the surface alone that the contact query keeps, of a volume, and of what is dear. */
    static const char *const names[] = {"chainmail", "kidney", "mass-spring", "hard hm1",
                                        "liver",     "xpbd",   "corotational"};
    const size_t count = FULL_IN_LONG_RUN(sizeof names / sizeof *names, FULL_IN_RELEASE(4, 1));
    write_block_mesh();
    bool is_good = true;
    for (int k = 0; k < BODIES; ++k) {
        bool is_one = false;
        for (size_t n = 0; n < count; ++n) {
            is_one = is_one || strcmp(names[n], bodies[k].name) == 0;
        }
        for (int is_through = 0; is_one && is_through < 2; ++is_through) {
            const body *b = &bodies[k];
            softsim_world *world = make_world(b, 8.0);
            double most = 0.0;
            const double thick = thickness_of(world);
            for (int n = 0; n < 700; ++n) {
                /* At .2 m/s, 15 mm deep to stay; through and on at .5 m/s to 2 m. */
                const double t = 1e-3 * n;
                const double deep = is_through
                                        ? 0.2 * t + 20.0 * fmax(0.0, t - 0.4) * fmax(0.0, t - 0.4)
                                        : fmin(0.02, 0.2 * t);
                double x[3];
                for (int a = 0; a < 3; ++a) {
                    x[a] = b->touch[a] + (deep - 0.005) * b->in[a];
                }
                const softsim_pose pose = pose_of(n + 1, x);
                const softsim_force force = feel(world, &pose);
                assert_true(isfinite(force.depth) && force.depth >= 0.0);
                most = fmax(most, force.depth);
            }
            print_message("%-13s %s: depth at most %.4g m in %.4g m\n", b->name,
                          is_through ? "through" : "deep", most, thick);
            is_good = is_good && most <= thick * (1.0 + 1e-6);
            softsim_destroy(&world);
        }
    }
    assert_true(is_good);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
