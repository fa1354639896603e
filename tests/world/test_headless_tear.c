/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * `contact.grasp_max_force_n`: a grasp that is drawn out of the tissue slowly is torn at that
 * force, and ends without a jolt; below it nothing changes. With the button still down the tool
 * takes hold of nothing any more, where it comes back; pressed anew it does.
 */
#include "common/test.h"

#include "common/effort.h"
#include "press_fixture.h"
#include "rt/vec.h"

/* Ticks of 1 ms. */
enum {
    PRESSED = 300,
    GRASPED = 350,
    FROM = 400,
    OUT = 1900,
    BACK_FROM = 2000,
    BACK = 2300,
    LET_GO = 2350,
    AGAIN = 2450,
    TICKS = 2550
};
#define DEPTH 0.003 /* m */
#define DRAWN 0.012 /* m */

static const body models[] = {
    {"kidney", "kidney.yaml", NULL, NULL, ON_KIDNEY, DEPTH},
    {"corotational", NULL, "  name: corotational\n" ELASTIC, NULL, ON_BLOCK, DEPTH},
    {"fem", NULL, "  name: fem\n" ELASTIC, NULL, ON_BLOCK, DEPTH},
    {"liver", "liver-chainmail.yaml", NULL, NULL, ON_LIVER, 0.001},
};
enum { MODELS = sizeof models / sizeof *models };
static const double rates[] = {1000.0, 100.0};

/* `limit` 0: the key is not given. */
static softsim_world *make(const body *b, double rate_hz, double limit)
{
    char rate[64], most[64];
    (void)snprintf(rate, sizeof rate, "simulation.rate_hz=%g", rate_hz);
    (void)snprintf(most, sizeof most, "contact.grasp_max_force_n=%.17g", limit);
    const char *const set[] = {rate, most};
    return open_body(b, set, limit > 0.0 ? 2 : 1);
}

static double part(int n, int from, int to)
{
    return smooth((double)(n - from) / (to - from));
}

/* In, hold, out of the tissue as far as it goes along, and in again; the button as said above. */
static softsim_pose hand(const body *b, int n)
{
    double x[3];
    const double out = DRAWN * (part(n, FROM, OUT) - part(n, BACK_FROM, BACK));
    ss_madd3(x, b->touch, (b->depth + 0.002) * part(n, 0, PRESSED) - 0.002 - out, b->in);
    softsim_pose pose = pose_of(n + 1, x);
    const bool is_down = n >= GRASPED && (n < LET_GO || n >= AGAIN);
    pose.buttons = is_down ? SOFTSIM_BUTTON_GRASP : 0;
    return pose;
}

typedef struct sample {
    double force[3], reaction, energy; /* N, N, J */
    bool is_grasping;
} sample;

static void run(const body *b, double rate_hz, double limit, sample out[TICKS])
{
    softsim_world *world = make(b, rate_hz, limit);
    for (int n = 0; n < TICKS; ++n) {
        const softsim_pose pose = hand(b, n);
        const softsim_force force = feel(world, &pose);
        softsim_state state;
        softsim_read(world, &state);
        ss_copy3(out[n].force, force.force);
        out[n].reaction = ss_norm3(force.model_force);
        out[n].energy = state.elastic_j + state.kinetic_j;
        out[n].is_grasping = (force.flags & SOFTSIM_FORCE_GRASPING) != 0;
    }
    softsim_destroy(&world);
}

static sample bare[TICKS], torn[TICKS];

static bool is_tear_good(const body *b, double rate_hz)
{
    double most = 0.0;
    run(b, rate_hz, 0.0, bare);
    for (int n = FROM; n < OUT; ++n) {
        assert_true(bare[n].is_grasping);
        most = fmax(most, bare[n].reaction);
    }
    /* Not reached: nothing changes. */
    run(b, rate_hz, 2.0 * most, torn);
    for (int n = 0; n < TICKS; ++n) {
        assert_memory_equal(torn[n].force, bare[n].force, sizeof bare[n].force);
        assert_int_equal(torn[n].is_grasping, bare[n].is_grasping);
    }
    const double limit = 0.6 * most;
    run(b, rate_hz, limit, torn);
    int end = GRASPED + 1;
    double reaction = 0.0, energy = 0.0, felt = 0.0;
    for (; end < TICKS && torn[end].is_grasping; ++end) {
        reaction = fmax(reaction, torn[end].reaction);
        energy = fmax(energy, torn[end].energy);
        felt = fmax(felt, ss_norm3(torn[end].force));
    }
    double rise = 0.0, more_energy = 0.0, after = 0.0;
    bool is_again = false;
    for (int n = end; n < AGAIN; ++n) {
        const double step = ss_norm3(torn[n].force) - ss_norm3(torn[n - 1].force);
        rise = n < BACK_FROM ? fmax(rise, step) : rise;
        more_energy = n < BACK_FROM ? fmax(more_energy, torn[n].energy - energy) : more_energy;
        is_again = is_again || torn[n].is_grasping;
    }
    for (int n = end + 100; n < BACK_FROM; ++n) {
        after = fmax(after, ss_norm3(torn[n].force));
    }
    const bool is_good = end > FROM && end < OUT && reaction >= limit && reaction <= 1.1 * limit &&
                         felt <= 1.1 * limit && rise <= 0.02 * limit && more_energy <= 1e-6 &&
                         after <= 0.1 * limit && !is_again && torn[TICKS - 1].is_grasping;
    print_message(
        "%s, %g Hz: pressed %.3f N, drawn %.3f N; limit %.3f N: at most %.3f, felt %.3f, "
        "gone in tick %d; then up %.4f N a tick, %.4f mJ, %.3f N left; again %d, anew %d%s\n",
        b->name, rate_hz, bare[FROM].reaction, most, limit, reaction, felt, end, rise,
        1e3 * more_energy, after, is_again, torn[TICKS - 1].is_grasping, is_good ? "" : ": BAD");
    return is_good;
}

TEST(a_grasp_is_torn_at_its_force_and_below_it_holds)
{
    bool is_good = true;
    for (int k = 0; k < MODELS; ++k) {
        for (size_t r = 0; r < FULL_IN_RELEASE(sizeof rates / sizeof *rates, 1); ++r) {
            is_good = is_tear_good(&models[k], rates[r]) && is_good;
        }
    }
    assert_true(is_good);
}

TEST(a_model_without_the_force_says_so)
{
    expect_chainmail_refuses("contact.grasp_max_force_n=2",
                             "contact.grasp_max_force_n: what chainmail grasps");
}

int main(void)
{
    return run_all_tests(make_folder_with_block, remove_folder);
}
