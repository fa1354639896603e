/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The cost of a step that is counted before a model is made, beside the sub-steps that it takes. */
#include "common/test.h"

#include "models/fem_quadratic/reference_fixture.h"

typedef struct count {
    double cost, substeps;
} count;

static count count_of(const char *model, double viscous_time, double rk4)
{
    setup s;
    setup_init(&s, model, load_reference("c_slab/mesh_300.msh"));
    s.plan.max_substeps = 100000;
    give(&s, "youngs_modulus_pa", 1e6); /* many sub-steps: whole numbers of them do not count */
    give(&s, "poisson_ratio", 0.45);
    give(&s, "stiffness_damping_s", viscous_time);
    give(&s, "integrator", rk4);
    count out = {.cost = s.class->step_cost_us(&s.plan)};
    create(&s);
    steps(&s, 1, 1e-3);
    out.substeps = info_of(&s).substeps;
    setup_fini(&s);
    return out;
}

/* A viscous sub-step costs at most twice an elastic one, whatever the processor. */
TEST(shorter_sub_steps_are_counted)
{
    static const char *const model[] = {"fem", "fem-quadratic"};
    for (int m = 0; m < 2; ++m) {
        for (int rk4 = 0; rk4 < 2; ++rk4) {
            const count elastic = count_of(model[m], 0.0, rk4);
            const count viscous = count_of(model[m], 5e-4, rk4);
            const double more = viscous.substeps / elastic.substeps;
            print_message("%s: %g and %g sub-steps, %.4g and %.4g us counted\n", model[m],
                          elastic.substeps, viscous.substeps, elastic.cost, viscous.cost);
            assert_true(more > 3.0);
            assert_true(viscous.cost > 0.8 * more * elastic.cost);
            assert_true(viscous.cost < 2.2 * more * elastic.cost);
        }
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
