/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Slew, watchdog, ramps and entry of the haptic tick, and what its hash tells apart. */
#include "common/test.h"

#include "haptic_fixture.h"

TEST(slew_is_limited_as_a_vector)
{
    ss_haptic_config config = default_config();
    config.max_slew = 100.0;
    rig r;
    rig_start(&r, &config);
    rig_press(&r, 1000.0, 2e-3);
    double last[3];
    for (int i = 0; i < 50; ++i) {
        ss_copy3(last, r.out.force.force);
        r.pose.position[0] = i * 1e-4;
        rig_tick(&r, i % 20 < 10 ? -8e-3 : 1e-3);
        ss_sub3(last, r.out.force.force, last);
        assert_true(ss_norm3(last) <= 0.1 + 1e-12);
    }
    rig_end(&r);
}

/* Pressed, and no pose comes any more; the force. */
static double rig_begin_lost(rig *r)
{
    const double f = rig_begin_pressed(r, 300.0, 4e-3);
    r->has_pose = false;
    return f;
}

TEST(watchdog_ramps_after_50_ticks_in_20)
{
    rig r;
    const double f = rig_begin_lost(&r);
    const int32_t gone = SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_STALE;
    for (int i = 1; i <= 100; ++i) {
        const double now = rig_tick(&r, -4e-3);
        const double share = i < 50 ? 1.0 : fmax(0.0, 1.0 - (i - 49) / 20.0);
        assert_near(now, share * f, 1e-6);
        assert_int_equal(r.out.force.flags & gone, i < 50 ? 0 : gone);
        assert_int_equal(r.out.target.is_present, i < 70);
        assert_int_equal(r.out.force.pose_seq, r.pose.seq);
    }
    assert_false(r.out.force.flags & SOFTSIM_FORCE_CONTACT);
    /* The next pose is taken wherever it is, and lets the device in by fading its depth. */
    const uint32_t teleports = r.out.target.teleports;
    r.has_pose = true;
    assert_near(rig_tick(&r, -10e-3), 0.0, 0.0);
    assert_true(r.out.target.is_present);
    assert_int_equal(r.out.target.teleports, teleports + 1);
    assert_near(r.out.target.proxy[2], -10e-3, 1e-12);
    rig_end(&r);
}

/* A thread that sleeps through the beginning of the ramp does not end it later. */
TEST(missed_ticks_do_not_lengthen_the_ramp)
{
    rig r;
    const double f = rig_begin_lost(&r);
    for (int i = 1; i <= 80; ++i) {
        if (i >= 48 && i <= 54) {
            ++r.tick;
            continue;
        }
        const double now = rig_tick(&r, -4e-3);
        assert_near(now, (i < 50 ? 1.0 : fmax(0.0, 1.0 - (i - 49) / 20.0)) * f, 1e-6);
    }
    rig_end(&r);
}

/* Nor does one that sleeps within a ramp, or an entry, end it in one step. */
TEST(missed_ticks_do_not_step_the_force)
{
    rig r;
    const double f = rig_begin_pressed(&r, 300.0, 4e-3);
    r.is_reset = true;
    for (int i = 1; i <= 20; ++i) {
        r.tick += i == 5 ? 200 : 0;
        assert_near(rig_tick(&r, -4e-3), (1.0 - i / 20.0) * f, 1e-6);
    }
    double last = 0.0;
    rig_tick(&r, -4e-3);
    for (int i = 0; i <= 500; ++i) {
        r.tick += i == 100 ? 200 : 0;
        rig_result(&r, 300.0, -r.out.target.proxy[2], 1);
        const double now = rig_tick(&r, -4e-3);
        assert_true(fabs(now - last) <= 0.01);
        last = now;
    }
    assert_near(last, f, 0.02);
    rig_end(&r);
}

/* Before the haptic loop hears of a reset, or the model does: results from across it are no law. */
TEST(results_from_across_a_reset_do_not_count)
{
    rig r;
    const double f = rig_begin_pressed(&r, 300.0, 4e-3);
    for (int i = 0; i < 50; ++i) {
        rig_result(&r, 300.0, -8e-3, 1); /* at rest, and no tool in it */
        r.ahead = 1;
        assert_near(rig_tick(&r, -4e-3), f, 1e-6);
    }
    r.restart_count = 1;
    for (int i = 1; i <= 100; ++i) {
        rig_result(&r, 300.0, 4e-3, 1); /* as it was */
        r.ahead = -1;
        assert_near(rig_tick(&r, -4e-3), fmax(0.0, 1.0 - i / 20.0) * f, 1e-6);
        assert_int_equal(r.out.target.restart_count, i > 20);
    }
    rig_end(&r);
}

/* The first tick of a device that is `depth` inside the tissue. */
static rig rig_found_inside(double depth)
{
    rig r;
    rig_begin(&r);
    rig_tick(&r, -depth);
    return r;
}

TEST(entry_fades_the_depth_over_500_ticks)
{
    rig r = rig_found_inside(5e-3);
    double last = 0.0;
    for (int i = 0; i <= 600; ++i) {
        rig_result(&r, 300.0, -r.out.target.proxy[2], 1);
        const double f = rig_tick(&r, -5e-3);
        const double share = fmin(1.0, i / 500.0);
        assert_near(f, share * 300.0 * 5e-3, 0.06);
        assert_true(fabs(f - last) < 0.01);
        assert_int_equal((r.out.force.flags & SOFTSIM_FORCE_RAMPING) != 0, i < 500);
        last = f;
    }
    /* reset: down in 20 ticks, then in again. */
    r.is_reset = true;
    rig_tick(&r, -5e-3);
    assert_near(r.out.force.force[2], 0.95 * last, 1e-2);
    for (int i = 1; i < 20; ++i) {
        rig_tick(&r, -5e-3);
    }
    assert_near(r.out.force.force[2], 0.0, 1e-12);
    rig_tick(&r, -5e-3);
    for (int i = 0; i <= 500; ++i) {
        rig_result(&r, 300.0, -r.out.target.proxy[2], 1);
        rig_tick(&r, -5e-3);
        assert_int_equal((r.out.force.flags & SOFTSIM_FORCE_RAMPING) != 0, i < 500);
    }
    rig_end(&r);
}

/* The tissue presses against a tool from the moment that it has its place in it: felt from no force
 * on, without a step. */
TEST(tissue_that_springs_back_is_let_in_without_a_step)
{
    rig r = rig_found_inside(5e-3);
    double last = 0.0;
    for (int i = 0; i <= 600; ++i) {
        rig_result(&r, 300.0, -r.out.target.proxy[2], 1);
        r.result.is_found_inside = i == 0;
        if (i == 0) {
            ss_set3(r.result.proxy, 0.0, 0.0, 0.0);
            ss_set3(r.result.outward, 0.0, 0.0, 1.0);
        }
        r.result.set.contact[0].force += 0.5 * fmax(0.0, 1.0 - i / 100.0);
        r.result.set.force[2] = r.result.set.contact[0].force;
        const double f = rig_tick(&r, -5e-3);
        assert_true(fabs(f - last) <= 0.02);
        last = f;
    }
    assert_near(last, 300.0 * 5e-3, 0.06);
    rig_end(&r);
}

TEST(late_results_ramp_with_the_fault_flag)
{
    rig r;
    const double f = rig_begin_pressed(&r, 300.0, 4e-3);
    const int32_t fault = SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_MODEL_FAULT;
    /* The last result was for the tick before the last. */
    for (int i = 1; i <= 600; ++i) {
        const double now = rig_tick(&r, -4e-3);
        const int over = i + 1 - 500;
        assert_near(now, over <= 0 ? f : fmax(0.0, 1.0 - over / 20.0) * f, 1e-6);
        assert_int_equal(r.out.force.flags & fault, over <= 0 ? 0 : fault);
        assert_true(r.out.force.flags & SOFTSIM_FORCE_PREDICTED);
        assert_int_equal(r.out.force.model_age_us, 1000 * (i + 1));
    }
    assert_true(r.out.target.is_present);
    /* It answers again: entry. */
    rig_result(&r, 300.0, 4e-3, 1);
    rig_tick(&r, -4e-3);
    rig_result(&r, 300.0, 0.0, 1);
    rig_tick(&r, -4e-3);
    assert_int_equal(r.out.force.flags & fault, SOFTSIM_FORCE_RAMPING);
    rig_end(&r);
}

TEST(fault_of_the_model_ramps)
{
    rig r;
    const double f = rig_begin_pressed(&r, 300.0, 4e-3);
    rig_result(&r, 300.0, 4e-3, 1);
    r.result.is_fault = true;
    r.result.set.contact[0].force = NAN;
    rig_tick(&r, -4e-3);
    for (int i = 1; i <= 25; ++i) {
        assert_near(rig_tick(&r, -4e-3), fmax(0.0, 1.0 - i / 20.0) * f, 1e-6);
        assert_true(r.out.force.flags & SOFTSIM_FORCE_MODEL_FAULT);
    }
    rig_end(&r);
}

TEST(pause_and_stop_ramp_without_the_fault_flag)
{
    for (int is_stop = 0; is_stop < 2; ++is_stop) {
        rig r;
        const double f = rig_begin_pressed(&r, 300.0, 4e-3);
        r.is_paused = !is_stop;
        r.is_stopping = is_stop;
        for (int i = 1; i <= 700; ++i) {
            assert_near(rig_tick(&r, -4e-3), fmax(0.0, 1.0 - i / 20.0) * f, 1e-6);
            assert_int_equal(r.out.force.flags &
                                 (SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_MODEL_FAULT),
                             SOFTSIM_FORCE_RAMPING);
        }
        /* Resume enters again; a stop is for good. */
        r.is_paused = false;
        r.is_stopping = false;
        r.is_reset = true;
        rig_tick(&r, -4e-3);
        for (int i = 0; i < 502; ++i) {
            rig_result(&r, 300.0, -r.out.target.proxy[2], 1);
            rig_tick(&r, -4e-3);
        }
        assert_near(r.out.force.force[2], is_stop ? 0.0 : f, 0.02);
        rig_end(&r);
    }
}

/* A hand that goes on into the tissue while the force ramps down, and tissue that comes against it:
 * each tick has at most its share of the force that the ramp found. */
TEST(nothing_raises_a_force_that_ramps_down)
{
    for (int is_tissue = 0; is_tissue < 2; ++is_tissue) {
        rig r;
        const double f = rig_begin_pressed(&r, 300.0, 4e-3);
        assert_true(f > 1.0);
        r.is_paused = true;
        for (int i = 1; i <= 20; ++i) {
            const double deeper = 4e-3 + 0.5e-3 * i;
            rig_result(&r, 300.0, is_tissue ? deeper : 4e-3, 1);
            const double now = rig_tick(&r, is_tissue ? -4e-3 : -deeper);
            assert_true(now >= 0.0 && now <= (1.0 - i / 20.0) * f + 1e-9);
        }
        rig_end(&r);
    }
}

/* A ramp that finds no force gives none, whatever the local contact model's offsets become
 * meanwhile. */
TEST(a_ramp_from_nothing_gives_nothing)
{
    rig r;
    rig_begin(&r);
    for (int i = 0; i < 20; ++i) {
        rig_tick(&r, -4e-3);
    }
    /* The tissue springs out to where the tool was put, as far as it was pressed in. */
    rig_result(&r, 300.0, 4e-3, 1);
    assert_near(rig_tick(&r, -4e-3), 0.0, 1e-12);
    rig_result(&r, 300.0, 4e-3, 1);
    r.result.proxy[2] = 0.0;
    assert_near(rig_tick(&r, -4e-3), 0.0, 1e-12);
    r.is_paused = true;
    for (int i = 0; i < 25; ++i) {
        rig_result(&r, 300.0, 4e-3, 1);
        r.result.set.inside_depth = 4e-3;
        assert_near(rig_tick(&r, -4e-3), 0.0, 1e-12);
        assert_false(r.out.force.flags & SOFTSIM_FORCE_CONTACT);
    }
    rig_end(&r);
}

/* Found inside, the tool goes out to the surface within a period. That jump is in the next result's
 * velocity, and in its reaction; the hand, still outside, feels neither at once. */
TEST(the_jump_to_the_surface_is_not_felt)
{
    rig r;
    rig_begin(&r);
    double last = 0.0;
    for (int i = 0; i < 60; ++i) {
        rig_result(&r, 300.0, i == 0 ? 8e-3 : 2e-3, 1);
        ss_copy3(r.result.proxy, r.out.target.proxy);
        r.result.set.contact[0].viscosity = i == 0 ? 0.0 : 1.0;
        r.result.velocity[2] = i == 4 ? 8.0 : 0.0;
        r.is_new = i > 0 && i % 2 == 0;
        const double f = rig_tick(&r, -8e-3);
        assert_true(fabs(f - last) <= 0.02);
        last = f;
    }
    rig_end(&r);
}

/* Two hands found at different depths under one point of the surface: their forces, both none yet,
 * and proxies are the same to the bit, and will not be. */
TEST(the_hash_tells_hands_apart_before_their_forces_do)
{
    uint64_t hash[2];
    for (int k = 0; k < 2; ++k) {
        const double depth = k == 0 ? 0x1p-8 : 0x1p-7;
        rig r;
        rig_begin(&r);
        rig_tick(&r, -depth);
        rig_result(&r, 512.0, depth, 1);
        assert_near(rig_tick(&r, -depth), 0.0, 0.0);
        assert_near(r.out.force.proxy[2], 0.0, 0.0);
        hash[k] = ss_haptic_hash(r.haptic, 1);
        rig_end(&r);
    }
    assert_true(hash[0] != hash[1]);
}

/* Each of what steers the force after the next result. */
TEST(the_hash_tells_laws_apart)
{
    static const struct {
        const char *what;
        size_t offset, size;
    } cases[] = {
#define CASE(field) {#field, offsetof(ss_local_contact, field), sizeof((ss_local_contact){0}.field)}
        CASE(free_ticks),         CASE(outward),          CASE(residual),
        CASE(released.force),     CASE(released.share),   CASE(min_offset_time),
        CASE(viscosity_fraction), CASE(grasp.last_force), CASE(grasp.offset),
        CASE(grasp.position),     CASE(grasp.is_held),    CASE(contact[0].last_force),
        CASE(contact[0].offset),  CASE(contact[0].drift),
#undef CASE
    };
    ss_local_contact local;
    ss_local_contact_clear(&local);
    local.count = 1;
    const uint64_t plain = ss_local_contact_hash(&local, 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        ss_local_contact other = local;
        ((unsigned char *)&other)[cases[i].offset] ^= 1U;
        if (ss_local_contact_hash(&other, 1) == plain) {
            fail_msg("the hash does not see %s", cases[i].what);
        }
    }
}

/* One is found inside once, the other in the step before, too: the simulation awaits another number
 * of entries, and all else is the same. */
TEST(the_hash_tells_entries_apart)
{
    uint64_t hash[2];
    for (int k = 0; k < 2; ++k) {
        rig r;
        rig_begin(&r);
        rig_tick(&r, 0.0);
        for (int i = 0; i < 2; ++i) {
            rig_result(&r, 300.0, 0.0, 1);
            r.result.is_found_inside = k == 0 || i == 1;
            r.result.outward[2] = 1.0;
            assert_near(rig_tick(&r, 0.0), 0.0, 0.0);
        }
        for (int i = 0; i < SS_RAMP_TICKS; ++i) {
            assert_near(rig_tick(&r, 0.0), 0.0, 0.0);
        }
        assert_int_equal(r.out.target.entries, 2 - k);
        hash[k] = ss_haptic_hash(r.haptic, 1);
        rig_end(&r);
    }
    assert_true(hash[0] != hash[1]);
}

/* A reset or pause while the depth still fades in: the ramp does not let the rest of it in. */
TEST(a_ramp_that_interrupts_an_entry_only_falls)
{
    rig r;
    rig_begin_pressed(&r, 300.0, 4e-3);
    for (int at = 50; at <= 450; at += 100) {
        double f = 0.0;
        r.is_reset = true;
        rig_tick(&r, -4e-3);
        r.is_reset = false;
        for (int i = 0; i < 22 + at; ++i) {
            rig_result(&r, 300.0, -r.out.target.proxy[2], 1);
            f = rig_tick(&r, -4e-3);
        }
        assert_true(f > 0.01);
        r.is_reset = true;
        for (int i = 0; i < 21; ++i) {
            rig_result(&r, 300.0, -r.out.target.proxy[2], 1);
            const double now = rig_tick(&r, -4e-3);
            r.is_reset = false;
            assert_true(now >= 0.0 && now <= f + 1e-3);
            f = now;
        }
        assert_true(f == 0.0);
    }
    rig_end(&r);
}

TEST(new_holder_starts_without_force)
{
    rig r;
    rig_begin(&r);
    assert_true(rig_press(&r, 300.0, 4e-3) > 1.0);
    ++r.epoch;
    r.pose.sender = 8;
    assert_near(rig_tick(&r, -8e-3), 0.0, 0.0);
    assert_int_equal(r.out.force.sender, 8);
    assert_near(r.out.force.proxy[2], -8e-3, 1e-12);
    rig_end(&r);
}

TEST(target_has_the_whole_orientation)
{
    static const double turned[4] = {0.5, -0.5, 0.1, 0.7};
    rig r;
    rig_begin(&r);
    memcpy(r.pose.orientation, turned, sizeof turned);
    rig_tick(&r, 1e-3);
    for (int i = 0; i < 4; ++i) {
        assert_near(r.out.target.orientation[i], turned[i], 0.0);
    }
    rig_end(&r);
}

/* The admission takes it wherever it is, before the ramp is over or even before the loop saw the
 * silence: the same device, so its force may not step. */
TEST(device_that_returns_elsewhere_ramps_first)
{
    const ss_haptic_config config = default_config();
    static const int silent_ticks[3] = {0, 49, 55};
    for (int k = 0; k < 3; ++k) {
        rig r;
        rig_start(&r, &config);
        const double f = rig_press(&r, 1000.0, 6e-3);
        assert_true(f > config.max_slew * T);
        r.has_pose = false;
        for (int i = 0; i < silent_ticks[k]; ++i) {
            rig_tick(&r, -6e-3);
        }
        const uint32_t teleports = r.out.target.teleports;
        double last = r.out.force.force[2];
        r.has_pose = true;
        ++r.epoch;
        int ticks = 0;
        while (r.out.target.teleports == teleports && ticks < 30) {
            const double now = rig_tick(&r, 0.5);
            assert_true(fabs(now - last) <= f / 20.0 + 1e-9);
            assert_true(r.out.force.flags & SOFTSIM_FORCE_RAMPING || now == 0.0);
            assert_int_equal(r.out.force.pose_seq, r.pose.seq);
            last = now;
            ++ticks;
        }
        assert_true(ticks > 10 && ticks <= 21);
        assert_near(last, 0.0, 0.0);
        assert_near(r.out.target.proxy[2], 0.5, 1e-12);
        rig_end(&r);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
