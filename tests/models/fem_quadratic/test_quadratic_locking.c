/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* A bar that is bent and a slab that is pulled are as soft as they should be, however little their
 * volume changes. */
#include "common/test.h"

#include "common/block_fixture.h"
#include "common/effort.h"
#include "common/setup_fixture.h"
#include "models/tissue_law.h"
#include "rt/each.h"
#include "rt/vec.h"

typedef struct trial {
    const char *name;
    block_size size;
    int along, push; /* axis from the glued end to the one that is moved; axis of the motion */
    double way;      /* m: so little that all laws agree */
    double force[4]; /* N at `ratios`: oracles/quadratic_static.h on cells of 5 mm */
} trial;

static const double ratios[4] = {0.3, 0.45, 0.49, 0.499};

/* The force that holds the end. */
static double settle(const trial *t, double ratio, int kind)
{
    setup s;
    double force[3];
    setup_init(&s, "fem-quadratic", make_block(&t->size));
    int32_t *node = calloc((size_t)s.mesh->node_count, sizeof *node), count = 0;
    double(*way)[3] = calloc((size_t)s.mesh->node_count, sizeof *way);
    give(&s, "youngs_modulus_pa", 1e4);
    give(&s, "poisson_ratio", ratio);
    give(&s, "material", kind);
    give(&s, "mass_damping_per_s", 80.0);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        const double x = s.mesh->position[i][t->along];
        s.fixed[i] = x < 1e-9 ? 7 : 0;
        if (x > t->size.size[t->along] - 1e-9) {
            node[count] = i;
            way[count++][t->push] = t->way;
        }
    }
    prescribe(&s, count, node, way, 0.05);
    create(&s);
    steps(&s, 400, 1e-3);
    s.class->reaction(s.model, 0, force);
    SS_EACH(free, node, way);
    setup_fini(&s);
    return force[t->push];
}

TEST(gives_way_as_much_as_it_should_at_any_ratio_by_any_law)
{
    static const trial trials[] = {
        {"bar, bent",
         {.cells = {8, 2, 2}, .size = {0.08, 0.02, 0.02}},
         0,
         2,
         4e-4,
         {0.00107949, 0.00110485, 0.0011178, 0.0011215}},
        {"slab, pulled",
         {.cells = {6, 6, 3}, .size = {0.04, 0.04, 0.02}},
         2,
         2,
         4e-6,
         {0.00364733, 0.00465127, 0.00522424, 0.0054027}},
    };
    for (size_t k = 0; k < sizeof trials / sizeof *trials; ++k) {
        for (int r = 0; r < 4; ++r) {
            for (int kind = 0; kind < FULL_IN_RELEASE(SS_TISSUE_KIND_COUNT, 1); ++kind) {
                const double force = settle(&trials[k], ratios[r], kind);
                const double give = trials[k].force[r] / force;
                print_message("%s, nu %g, law %d: %.6g N, gives way %.4f of what it should\n",
                              trials[k].name, ratios[r], kind, force, give);
                assert_true(give >= 0.97 && give < 1.02);
            }
        }
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
