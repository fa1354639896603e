/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A body at rest sleeps, and nobody can feel it, whatever its model: on a block of each, what wakes
 * it that is no tool, what creeps and must not be stopped, and equal bits for all numbers of
 * threads.
 */
#include "common/test.h"

#include "common/effort.h"
#include "sleep_fixture.h"

#define ELASTIC_OF(name, damping)                                                                  \
    "  name: " name "\n  youngs_modulus_pa: 60000\n  poisson_ratio: 0.4\n"                         \
    "  density_kg_m3: 1060\n  mass_damping_per_s: " damping "\n"
#define SPRINGS(damping)                                                                           \
    "  name: mass-spring\n  youngs_modulus_pa: 60000\n  density_kg_m3: 1060\n"                     \
    "  mass_damping_per_s: " damping "\n"
#define NETWORK(damping)                                                                           \
    "  name: cnn-energy\n  domain: volume\n  modulus_pa: 400000\n  density_kg_m3: 1060\n"          \
    "  rest_stiffness_n_per_m4: 3.0e+7\n  damping_n_s_per_m4: " damping "\n"
#define LAYER "  layer: {spacing_m: 0.003, thickness_m: -0.005}\n"
/* Where the core of hybrid is. */
#define HELD_IN_CORE "object.fixed=[{box_m: [[-1, -1, -1], [1, 1, 0.0068]]}]"

static const body each[] = {
    {"fem", NULL, ELASTIC_OF("fem", "30"), NULL, ON_BLOCK, 0.006},
    {"cnn-energy", NULL, NETWORK("100000"), NULL, ON_BLOCK, 0.006},
    {"cnn-chainmail", NULL, "  name: cnn-chainmail\n  leak_resistance: 10\n", NULL, ON_BLOCK,
     0.006},
    {"hybrid", NULL, ELASTIC_OF("hybrid", "30") LAYER, HELD_IN_CORE, ON_BLOCK, 0.006},
    {"corotational", NULL, ELASTIC_OF("corotational", "30"), NULL, ON_BLOCK, 0.006},
    {"xpbd", NULL, ELASTIC_OF("xpbd", "30"), NULL, ON_BLOCK, 0.006},
    {"mass-spring", NULL, SPRINGS("30"), NULL, ON_BLOCK, 0.006},
    {"chainmail", NULL, "  name: chainmail\n  alpha: 0.05\n  beta: 0.05\n", NULL, ON_BLOCK, 0.006},
    {"fem-quadratic", NULL, ELASTIC_OF("fem-quadratic", "30"), NULL, ON_BLOCK, 0.006},
};
enum { EACH = sizeof each / sizeof *each };

/* All of them in a long run, of each kind one in a short one, one alone where that is repeated. */
static bool is_run(const body *b)
{
    static const char *const in_short_run[] = {"corotational", "cnn-energy", "cnn-chainmail",
                                               "chainmail"};
    bool is_any = is_long_run();
    for (int k = 0; k < FULL_IN_RELEASE(4, 1); ++k) {
        is_any = is_any || strcmp(in_short_run[k], b->name) == 0;
    }
    return is_any;
}

static int make_folder_with(const int cells[3])
{
    static const double size[3] = {60.0, 60.0, 20.0};
    const int result = make_folder(NULL);
    write_box_mesh(cells, size);
    return result;
}

static int make_folder_with_small_block(__attribute__((unused)) void **state)
{
    return make_folder_with((const int[3]){6, 6, 3});
}

static int make_folder_with_coarse_block(__attribute__((unused)) void **state)
{
    return make_folder_with((const int[3]){4, 4, 3});
}

/* ---- loads, supports and commands ---- */

/* A load that sets in after more than a second of sleep, and is gone again, and a support that
 * moves, with a tool that rests. */
TEST_WITH(loads_and_supports_wake_it, make_folder_with_small_block, remove_folder)
{
    const char *const acts[] = {
        "loads=[{sphere: {center_m: [0.02, 0, 0.02], radius_m: 0.006}, force_n: [0, 0, -1], "
        "from_s: 4.5, to_s: 7, ramp_s: 0.2}]",
        "prescribed=[{sphere: {center_m: [-0.02, 0, 0.02], radius_m: 0.006}, displacement_m: [0, "
        "0, -0.002], from_s: 8.5, ramp_s: 0.3}]"};
    const part parts[] = {{10, FAR_OUT, 0, 0, 0, false}, {400, 0.003, 0, 0, 0, false},
                          {4050, 0.003, 0, 0, 0, true},  {2500, 0.003, 0, 0, 0, false},
                          {1500, 0.003, 0, 0, 0, false}, {1500, 0.003, 0, 0, 0, false}};
    for (int i = 0; i < EACH; ++i) {
        const body *b = &each[i];
        if (is_run(b)) {
            const bool has_forces = strcmp(b->name, "chainmail") != 0; /* or it refuses loads */
            pair p = open_pair(b, has_forces ? acts : acts + 1, has_forces ? 2 : 1);
            play(&p, b, parts, sizeof parts / sizeof *parts);
            close_pair(&p, b->name);
        }
    }
}

/* Held at rest, and let go, with a value set each time after a while of sleep. */
static void set_asleep(const body *b, const char *const *values, int count)
{
    const double d = 0.003;
    const int still = FULL_IN_LONG_RUN(20000, 3500);
    const part press[] = {
        {10, FAR_OUT, 0, 0, 0, false}, {400, d, 0, 0, 0, false}, {still, d, 0, 0, 0, true}};
    const part hold[] = {{1, d, 0, 0, 0, false}, {1000, d, 0, 0, 0, false}};
    const part leave[] = {
        {1, d, 0, 0, 0, false}, {400, FAR_OUT, 0, 0, 0, false}, {still, FAR_OUT, 0, 0, 0, true}};
    const part again[] = {
        {1, FAR_OUT, 0, 0, 0, false}, {400, d, 0, 0, 0, false}, {1000, d, 0, 0, 0, false}};
    pair p = open_pair(b, NULL, 0);
    play(&p, b, press, 3);
    for (int k = 0; k < count - 1; ++k) {
        set_both(&p, values[k]);
        play(&p, b, hold, 2);
    }
    play(&p, b, leave, 3);
    set_both(&p, values[count - 1]);
    play(&p, b, again, 3);
    close_pair(&p, b->name);
}

/* The last is set with no tool near. */
TEST_WITH(what_is_set_while_it_sleeps_is_felt, make_folder_with_small_block, remove_folder)
{
    static const body kidney = {"kidney", "kidney.yaml", NULL, NULL, ON_KIDNEY, 0.003};
    const char *const of_the_hand[] = {"haptic.coupling.stiffness_n_per_m=200",
                                       "haptic.max_force_n=0.1", "haptic.max_slew_n_per_s=500",
                                       "haptic.coupling.damping_n_s_per_m=0.5"};
    const char *const of_a_volume[] = {"model.modulus_pa=300000", "haptic.max_force_n=0.05",
                                       "model.modulus_pa=600000"};
    const char *const of_a_surface[] = {"model.modulus_j=4", "model.pretension_j=0.8",
                                        "model.modulus_j=6"};
    for (int i = 0; i < EACH; ++i) {
        const bool has_own = strcmp(each[i].name, "cnn-energy") == 0;
        if (is_run(&each[i])) {
            set_asleep(&each[i], has_own ? of_a_volume : of_the_hand, has_own ? 3 : 4);
        }
    }
    if (FULL_IN_RELEASE(true, false)) {
        set_asleep(&kidney, of_a_surface, 3);
    }
}

/* ---- threads ---- */

/* With one and with three, whose worker steps while ticks run: asleep in the air, and pressed. */
TEST_WITH(the_hash_after_sleep_is_the_same_for_any_number_of_threads, make_folder_with_small_block,
          remove_folder)
{
    SKIP_WHERE_REPEATED();
    for (int i = 0; i < EACH; ++i) {
        const body *b = &each[i];
        uint64_t hash[2] = {0, 0};
        for (int k = 0; is_run(b) && k < 2; ++k) {
            softsim_config config = softsim_default_config();
            config.threads = k == 0 ? 1 : 3;
            config.set = &b->set;
            config.set_count = b->set != NULL;
            softsim_world *world = make_world_with(write_block(b), config);
            for (int n = 1; n <= 3000; ++n) {
                double x[3];
                const double in = FAR_OUT + (0.003 - FAR_OUT) * smooth((n - 2200) / 400.0);
                ss_madd3(x, b->touch, in, b->in);
                const softsim_pose pose = pose_of(n, x);
                (void)feel(world, &pose);
                if (n == 2000) {
                    softsim_state asleep;
                    softsim_read(world, &asleep);
                    assert_int_equal(asleep.active_nodes, 0);
                }
            }
            hash[k] = softsim_hash(world);
            softsim_destroy(&world);
        }
        assert_true(hash[0] == hash[1]);
    }
}

/* ---- what creeps ---- */

/* Slow by damping. None so slow that it tells two presses of its own apart: a chain of
 * capacitance_s 1, awake and pressed one tick later, answers by 5e-3 of the force otherwise. */
typedef struct creep {
    body body;
    int still, away; /* ticks, in a short run: held, and let go; below 0: in a long run alone */
} creep;
#define CREEP(name, model, set, still, away)                                                       \
    {                                                                                              \
        {name, NULL, model, set, ON_BLOCK, 0.004}, still, away                                     \
    }

static const creep creeps[] = {
    CREEP("fem", ELASTIC_OF("fem", "1500000"), NULL, 500, 20000),
    CREEP("slow fem", ELASTIC_OF("fem", "3000000"), NULL, -1, -1),
    CREEP("hybrid", ELASTIC_OF("hybrid", "500000") LAYER, HELD_IN_CORE, -1, -1),
    CREEP("corotational", ELASTIC_OF("corotational", "30") "  stiffness_damping_s: 3\n", NULL, -1,
          -1),
    CREEP("xpbd", ELASTIC_OF("xpbd", "500000"), NULL, -1, -1),
    CREEP("mass-spring", SPRINGS("50000"), NULL, -1, -1),
    CREEP("cnn-energy", NETWORK("10000000"), NULL, -1, -1),
    CREEP("cnn-energy, relaxing",
          NETWORK("10000000") "  solver: relaxation\n  relaxation_steps: 1\n", NULL, 2000, 4000),
    CREEP("cnn-chainmail", "  name: cnn-chainmail\n", NULL, 6000, 4000),
    CREEP("cnn-chainmail, leaking", "  name: cnn-chainmail\n  leak_resistance: 200\n", NULL, -1,
          -1),
    CREEP("cnn-chainmail, slow", "  name: cnn-chainmail\n  capacitance_s: 0.1\n", NULL, -1, -1),
    CREEP("fem-quadratic", ELASTIC_OF("fem-quadratic", "100000") "  material: neo-hookean\n", NULL,
          -1, -1)};

/* Pressed and held while it gives way, let go and left alone while it comes back, and pressed
 * again: where it had come to, and what it was still doing, is what the awake one tells. */
TEST_WITH(what_creeps_is_not_frozen, make_folder_with_coarse_block, remove_folder)
{
    SKIP_WHERE_REPEATED();
    for (size_t i = 0; i < sizeof creeps / sizeof *creeps; ++i) {
        const body *b = &creeps[i].body;
        if (!FULL_IN_LONG_RUN(true, creeps[i].still > 0)) {
            continue;
        }
        const int still = FULL_IN_LONG_RUN(60000, creeps[i].still);
        const int away = FULL_IN_LONG_RUN(60000, creeps[i].away);
        const part press[] = {{10, FAR_OUT, 0, 0, 0, false},
                              {400, b->depth, 0, 0, 0, false},
                              {still, b->depth, 0, 0, 0, false},
                              {400, FAR_OUT, 0, 0, 0, false},
                              {away, FAR_OUT, 0, 0, 0, false}};
        const part again[] = {{1, FAR_OUT, 0, 0, 0, false},
                              {400, b->depth, 0, 0, 0, false},
                              {1000, b->depth, 0, 0, 0, false}};
        pair p = open_pair(b, NULL, 0);
        play(&p, b, press, 5);
        assert_true(ss_sleep_is_asleep(ss_world_of(p.slept)->sleep));
        play(&p, b, again, 3);
        close_pair(&p, b->name);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
