/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Which particles of a hybrid wake, and that what is kept between steps is of now. */
#include "common/test.h"

#include "common/effort.h"
#include "common/note_fixture.h"
#include "hybrid_fixture.h"
#include "rt/hash.h"

/* The forces of now are those of rows that are gathered again, to the bit. */
static void assert_forces_are_gathered(ss_hybrid *hybrid)
{
    const size_t size = 4 * (size_t)ss_body_read_nodes(hybrid->body)->count * sizeof(ss_real);
    double energy[2];
    ss_real *force = forces_of(hybrid, &energy[0]);
    hybrid->is_near_old = true;
    ss_real *gathered = forces_of(hybrid, &energy[1]);
    assert_memory_equal(force, gathered, size);
    assert_true(energy[0] == energy[1]);
    free(force);
    free(gathered);
}

/* How the tools of a short look move: one slides; it is put elsewhere at once, leaves and appears;
 * two cross. */
enum { SLIDES, JUMPS, CROSSES, WAYS };

static void lead(setup *s, ss_model_tool tool[SOFTSIM_MAX_PROBES], int way, int k)
{
    const double swing = 0.3 * sin(0.03 * k);
    tool[0].is_present = way != JUMPS || k % 80 < 70;
    if (way == JUMPS && k % 20 == 0) {
        tool[0].to.position[0] = k % 40 == 0 ? -0.5 : 0.5; /* beside it: few are in reach */
        tool[0].to.position[2] = k % 60 == 0 ? 2.0 : 0.95;
    }
    if (way == CROSSES) {
        tool[1] = tool[0];
        tool[1].to.position[0] = 0.35 - swing;
        tool[1].to.position[1] = 0.6;
    }
    move(s, tool, way == JUMPS ? tool[0].to.position[0] : 0.35 + swing,
         way == JUMPS ? 1.05 - tool[0].to.position[2] : 0.1, 1);
}

/* The wanted particles, a bit each. */
static uint64_t hash_wanted(const ss_hybrid *hybrid)
{
    uint64_t hash = SS_HASH_START;
    for (int32_t p = 0; p < hybrid->layer->count; ++p) {
        const unsigned char is_wanted = hybrid->particle[p].wanted >= 0;
        hash = ss_hash_bytes(hash, &is_wanted, 1);
    }
    return hash;
}

/* A tool over more particles than may be awake: a look that stays near it finds what a look at all
 * within sleep_reach does, to the bit; those in reach of two tools may only wake in another order.
 */
TEST(short_look_is_enough)
{
    SKIP_WHERE_REPEATED();
    enum { STEPS = 240 };
    static uint64_t hash[2][STEPS];
    for (int way = 0; way < WAYS; ++way) {
        int32_t shorter = 0;
        int32_t most = 0;
        for (int is_whole = 0; is_whole < 2; ++is_whole) {
            setup s;
            ss_model_tool tool[SOFTSIM_MAX_PROBES];
            init_block(&s, 150);
            add_sphere(&s, 1, 0.1);
            give_row(&s, SS_HYBRID_ACTIVATE, 0.6);
            ss_hybrid *hybrid = start_hybrid(&s);
            start_tool(tool, 0.35);
            move(&s, tool, 0.35, 0.1, 60);
            for (int k = 0; k < STEPS; ++k) {
                hybrid->current_sleep_reach =
                    is_whole ? hybrid->sleep_reach : hybrid->current_sleep_reach;
                lead(&s, tool, way, k);
                shorter += hybrid->current_sleep_reach < 0.5 * hybrid->sleep_reach;
                most = hybrid->awake_count > most ? hybrid->awake_count : most;
                assert_forces_are_gathered(hybrid);
                hash[is_whole][k] =
                    way == CROSSES ? hash_wanted(hybrid) : s.class->hash(s.model, 1);
            }
            setup_fini(&s);
        }
        assert_memory_equal(hash[0], hash[1], sizeof hash[0]);
        assert_true(most > 100);
        assert_true(shorter > STEPS / 4);
    }
}

/* Particles that are released and wait for their tie under a dent cost no new forces. */
TEST(waiting_changes_nothing)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    int32_t waited = 0;
    ss_hybrid *hybrid = start_block(&s, 150);
    start_tool(tool, 0.5);
    move(&s, tool, 0.5, 0.15, 60);
    assert_true(hybrid->awake_count > 50);
    hybrid->wake_reach = 1e-3;
    hybrid->current_sleep_reach = hybrid->sleep_reach = 2e-3;
    memset(hybrid->was_scanned, 0, sizeof hybrid->was_scanned);
    const int32_t most = hybrid->awake_count;
    for (int k = 0; k < 40; ++k) {
        const uint64_t before = s.class->hash(s.model, 1);
        const int32_t awake = hybrid->awake_count;
        hybrid->step_counter = 0; /* its turn */
        if (!ss_hybrid_wake(hybrid)) {
            assert_true(s.class->hash(s.model, 1) == before);
            assert_int_equal(hybrid->awake_count, awake);
            waited += hybrid->is_fading;
        }
    }
    assert_true(waited > 0);
    assert_true(hybrid->awake_count < most / 2);
    setup_fini(&s);
}

/* A blend, a theta or an offset alone that moves asks for new forces; then there is rest. */
TEST(each_change_is_told)
{
    setup s;
    ss_hybrid *hybrid = start_block(&s, 100);
    ss_hybrid_wake_around(hybrid, hybrid->layer->skin_count / 2);
    const int32_t p = hybrid->wanted[0];
    for (int k = 0; k < 3; ++k) {
        hybrid->step_counter = 0; /* its turn */
        assert_false(ss_hybrid_wake(hybrid));
        if (k == 0) {
            hybrid->particle[p].target = (ss_real)0.5;
            hybrid->is_fading = true;
        } else if (k == 1) {
            hybrid->ride[hybrid->riding[0]].theta = (ss_real)0.5;
            hybrid->is_skin_fading = true;
        } else {
            hybrid->drifting[hybrid->drifting_count++] = hybrid->layer->own_count - 1;
        }
        hybrid->step_counter = 0;
        assert_true(ss_hybrid_wake(hybrid));
    }
    setup_fini(&s);
}

/* Where there is room for all particles, all in reach wake, and no limit is told of. */
TEST(room_for_all_is_no_limit)
{
    for (int k = 0; k < 2; ++k) {
        setup s;
        ss_model_tool tool[SOFTSIM_MAX_PROBES];
        init_block(&s, k == 0 ? 300 : 1000000);
        give_row(&s, SS_HYBRID_ACTIVATE, 1.2);
        ss_hybrid *hybrid = start_hybrid(&s);
        const int32_t all = hybrid->layer->own_count;
        assert_int_equal(
            note_count(s.class, s.model, SS_NOTE_WARNING, "model.layer.max_active", ""), k == 0);
        start_tool(tool, 0.5);
        move(&s, tool, 0.5, 0.1, 60);
        assert_true((hybrid->wanted_count == all) == (k == 1));
        setup_fini(&s);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
