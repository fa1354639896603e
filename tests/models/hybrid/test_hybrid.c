/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "common/test.h"

#include "common/effort.h"
#include "common/note_fixture.h"
#include "hybrid_fixture.h"
#include "models/common/body_state.h"
#include "rt/hash.h"
#include "rt/random.h"

static const double origin[3] = {0.0, 0.0, 0.0};

static bool is_at_ends(int i, int j, int k)
{
    (void)j;
    (void)k;
    return i < 2 || i >= 4;
}

/* ---- statics ---- */

/* Force on the moved end of a bar, tetrahedra | particles | tetrahedra, stretched by 1 % with its
 * sides free, N. */
static double bar_force(double cohesion, double stabilisation)
{
    const int n[3] = {6, 2, 2};
    const double length = 3.0;
    setup s;
    setup_hybrid(&s, make_bar(n, 0.5, origin, 0.0, is_at_ends), 0.125);
    give_row(&s, SS_HYBRID_COHESION, cohesion);
    give_row(&s, SS_HYBRID_STABILISATION, stabilisation);
    give_row(&s, SS_FEM_MASS_DAMPING, 2.5);
    wake_all(&s);
    int32_t node[2][9];
    double moved[9][3] = {{0}};
    int32_t count[2] = {0, 0};
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        const double *x = s.mesh->position[i];
        const int end = x[0] == 0.0 ? 0 : x[0] == length ? 1 : -1;
        if (end >= 0) {
            node[end][count[end]++] = i;
            /* No more than keeps it from turning and sliding. */
            s.fixed[i] =
                (uint8_t)((end == 0 ? 1u : 0u) | (x[1] == 0.5 ? 2u : 0u) | (x[2] == 0.5 ? 4u : 0u));
        }
    }
    for (int32_t k = 0; k < count[1]; ++k) {
        moved[k][0] = 0.01 * length;
    }
    const ss_prescribed set = {.node = node[1],
                               .node_count = count[1],
                               .displacement = moved,
                               .axis = {true, false, false},
                               .ramp = 2.0};
    s.plan.prescribed = &set;
    s.plan.prescribed_count = 1;
    (void)start_hybrid(&s);
    for (int k = 0; k < 150; ++k) {
        s.class->step(s.model, 0.1 * k, 0.1, NULL);
    }
    double force[3];
    s.class->reaction(s.model, 0, force);
    const ss_model_info info = info_of(&s);
    assert_int_equal(info.fault_bits, 0);
    setup_fini(&s);
    return force[0];
}

/* Young's modulus of lambda 5.5, mu 2.5 is 6.71875; free lateral stretch by 1 % of the guarded law
 * takes P = 6.71875 (1.01^3 - 1.01)/2. */
TEST(bar_carries_the_exact_force)
{
    SKIP_WHERE_REPEATED();
    const double exact = 6.71875 * (1.01 * 1.01 * 1.01 - 1.01) / 2.0;
    assert_near(bar_force(0.0, 0.0) / exact, 1.0, 0.03);
    assert_near(bar_force(0.0, 0.3) / exact, 1.0, 0.03);
    assert_near(bar_force(0.05, 0.3) / exact, 1.0, 0.03);
}

/* ---- time ---- */

/* Energy of free motion of size `size` over `steps` leapfrog steps of `share` of dt*: the largest,
 * over the first. Plain arithmetic, beside the model's own integrator. */
static double growth(double share, int steps, double size, int32_t awake, double *out_momentum)
{
    setup s;
    setup_hybrid(&s, make_bar((const int[3]){4, 4, 4}, 0.25, origin, 0.3, is_below_2), 0.1);
    give_row(&s, SS_HYBRID_MAX_ACTIVE, awake);
    give_row(&s, SS_HYBRID_ACTIVATE, 0.3);
    give_row(&s, SS_HYBRID_COHESION, 0.0);
    ss_hybrid *hybrid = start_hybrid(&s);
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    /* dt* of this very state: asleep, or with these awake. */
    ss_hybrid_wake_around(hybrid, hybrid->layer->skin_count / 2);
    const double rate2 = ss_hybrid_converge_rate(hybrid);
    const double h = share * 2.0 / sqrt(rate2);
    uint64_t seed = 11;
    double drift[3] = {0};
    double total = 0.0;
    for (int32_t i = 0; i < nodes->count; ++i) {
        for (int a = 0; a < 3 && nodes->mass[i] > 0.0; ++a) {
            nodes->v[4 * (ptrdiff_t)i + a] = (ss_real)(size * (ss_random_unit(&seed) - 0.5));
            drift[a] += nodes->mass[i] * (double)nodes->v[4 * (ptrdiff_t)i + a];
        }
        total += nodes->mass[i];
    }
    double first = 0.0;
    double largest = 0.0;
    double speed = 0.0;
    double end[3] = {0};
    for (int k = 0; k < steps; ++k) {
        double elastic;
        double kinetic = 0.0;
        ss_real *force = forces_of(hybrid, &elastic);
        ss_set3(end, 0.0, 0.0, 0.0);
        for (int32_t i = 0; i < nodes->count; ++i) {
            for (int a = 0; a < 3 && nodes->mass[i] > 0.0; ++a) {
                const ptrdiff_t at = 4 * (ptrdiff_t)i + a;
                const double before = (double)nodes->v[at];
                const double after = before + h * (double)force[at] / nodes->mass[i];
                kinetic += 0.5 * nodes->mass[i] * before * after;
                nodes->v[at] = (ss_real)after;
                nodes->u[at] = (ss_real)((double)nodes->u[at] + h * after);
                end[a] += nodes->mass[i] * after;
                speed = fmax(speed, fabs(after));
            }
        }
        first = k == 0 ? kinetic + elastic : first;
        largest = fmax(largest, kinetic + elastic);
        free(force);
        if (!(largest < 1e3 * first)) {
            break;
        }
    }
    ss_sub3(drift, end, drift);
    *out_momentum = ss_norm3(drift) / (total * size);
    setup_fini(&s);
    return largest / first;
}

TEST(reported_step_is_the_limit)
{
    double momentum;
    for (int32_t awake = 1; awake <= 60; awake += 59) {
        const double tiny = BY_TYPE(1e-4, 1e-6);
        assert_true(growth(0.97, 400, tiny, awake, &momentum) < 50.0);
        assert_true(growth(1.03, 1500, tiny, awake, &momentum) > 100.0);
    }
}

TEST(motion_keeps_energy_and_momentum)
{
    SKIP_WHERE_REPEATED();
    double momentum;
    const double kept = growth(0.5, 10000, 0.05, 60, &momentum);
    assert_near(kept, 1.0, 0.01);
    assert_near(momentum, 0.0, BY_TYPE(1e-4, 1e-11));
}

/* ---- tools ---- */

static double felt(setup *s)
{
    ss_contact_set set;
    s->class->contacts(s->model, 0, 0.01, &set);
    return set.force[2];
}

/* Total mass and momentum of the body, and the volume that all of it stands for. */
static void sum_up(const ss_hybrid *hybrid, double *out_mass, double out_momentum[3],
                   double *out_volume)
{
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    *out_mass = *out_volume = 0.0;
    ss_set3(out_momentum, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < nodes->count; ++i) {
        *out_mass += nodes->mass[i];
        for (int a = 0; a < 3; ++a) {
            out_momentum[a] += nodes->mass[i] * (double)nodes->v[4 * (ptrdiff_t)i + a];
        }
    }
    for (int32_t e = 0; e < hybrid->mesh->tetrahedron_count; ++e) {
        *out_volume += hybrid->volume[e];
    }
    for (int32_t k = 0; k < hybrid->cells.count; ++k) {
        *out_volume += hybrid->cell_volume[k];
    }
    for (int32_t k = 0; k < hybrid->point_count; ++k) {
        const int32_t p = hybrid->point[k];
        *out_volume += (double)hybrid->particle[p].blend * hybrid->layer->volume[p];
    }
}

static double kinetic_of(const ss_hybrid *hybrid)
{
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    double energy = 0.0;
    for (int32_t i = 0; i < nodes->count; ++i) {
        for (int a = 0; a < 3; ++a) {
            const double v = (double)nodes->v[4 * (ptrdiff_t)i + a];
            energy += 0.5 * nodes->mass[i] * v * v;
        }
    }
    return energy;
}

/* Waking and falling asleep of particles in motion keep mass, momentum and volume, and do not gain
 * kinetic energy. */
TEST(waking_keeps_mass_and_momentum)
{
    setup s;
    init_block(&s, 100);
    memset(s.fixed, 0, (size_t)s.mesh->node_count);
    ss_hybrid *hybrid = start_hybrid(&s);
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    uint64_t seed = 5;
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        for (int a = 0; a < 3 && nodes->mass[i] > 0.0; ++a) {
            nodes->v[4 * (ptrdiff_t)i + a] = (ss_real)(ss_random_unit(&seed));
        }
    }
    double mass[3], momentum[3][3], volume[3];
    sum_up(hybrid, &mass[0], momentum[0], &volume[0]);
    double kinetic = kinetic_of(hybrid);
    ss_hybrid_wake_around(hybrid, hybrid->layer->skin_count / 2);
    assert_int_equal(hybrid->awake_count, 100);
    assert_true(kinetic_of(hybrid) <= kinetic);
    kinetic = kinetic_of(hybrid);
    sum_up(hybrid, &mass[1], momentum[1], &volume[1]);
    ss_hybrid_reset_layer(hybrid);
    assert_true(kinetic_of(hybrid) <= kinetic);
    assert_int_equal(hybrid->awake_count, 0);
    assert_int_equal(hybrid->point_count, 0);
    assert_int_equal(hybrid->near_count, 0);
    sum_up(hybrid, &mass[2], momentum[2], &volume[2]);
    for (int k = 1; k < 3; ++k) {
        assert_near(mass[k] / mass[0], 1.0, 1e-12);
        assert_near(volume[k] / volume[0], 1.0, BY_TYPE(1e-6, 1e-12));
        for (int a = 0; a < 3; ++a) {
            assert_near(momentum[k][a] / mass[0], momentum[0][a] / mass[0], BY_TYPE(1e-6, 1e-13));
        }
    }
    setup_fini(&s);
}

/* A tool that passes to and fro over a body that swings, undamped, and does not touch it, so that
 * particles wake and sleep all the time, gives it no energy. */
TEST(passing_tool_gives_no_energy)
{
    SKIP_WHERE_REPEATED();
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    ss_model_info info;
    double first = 0.0;
    double largest = 0.0;
    init_block(&s, 400);
    give_row(&s, SS_HYBRID_ACTIVATE, 0.4);
    give_row(&s, SS_FEM_MASS_DAMPING, 0.0);
    s.plan.tool[0].shape.radius = 0.1;
    ss_hybrid *hybrid = start_hybrid(&s);
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        const double *x = s.mesh->position[i];
        const double v[3] = {sin(6.28 * x[2]), sin(6.28 * x[0]), cos(6.28 * x[0])};
        for (int a = 0; a < 3 && nodes->mobility[4 * (ptrdiff_t)i] > 0; ++a) {
            nodes->v[4 * (ptrdiff_t)i + a] = (ss_real)(0.1 * v[a]);
        }
    }
    ss_body_renew(hybrid->body);
    start_tool(tool, 0.5);
    tool[0].to.position[2] = 1.0;
    for (int k = 0; k < 1200; ++k) {
        tool[0].from = tool[0].to;
        tool[0].to.position[0] = 0.5 + 0.5 * sin(0.05 * k);
        s.class->step(s.model, 0.0, 0.005, tool);
        s.class->info(s.model, &info);
        first = k == 0 ? info.kinetic + info.elastic : first;
        largest = fmax(largest, info.kinetic + info.elastic);
        assert_true(hybrid->body->tools.tool[0].penalty == 0.0);
    }
    assert_true(hybrid->awake_count > 100);
    assert_true(largest < 1.05 * first);
    setup_fini(&s);
}

/* Force grows with depth, particles wake under the tool and sleep again when it goes; at rest the
 * body comes back to rest. */
TEST(tool_wakes_what_it_touches)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    ss_hybrid *hybrid = start_block(&s, 150);
    start_tool(tool, 0.5);
    double before = 0.0;
    for (int k = 1; k <= 6; ++k) {
        move(&s, tool, 0.5, 0.025 * k, 20);
        move(&s, tool, 0.5, 0.025 * k, 40);
        assert_true(felt(&s) > before);
        before = felt(&s);
    }
    assert_true(hybrid->awake_count > 50 && hybrid->awake_count <= 150);
    for (int32_t p = 0; p < hybrid->layer->own_count; ++p) {
        const double *x = hybrid->layer->rest[p];
        assert_true(hybrid->node_of[p] < 0 || hypot(x[0] - 0.5, x[1] - 0.5) < 0.5);
    }
    const ss_model_info info = info_of(&s);
    assert_int_equal(info.verdict, SOFTSIM_VERDICT_GOOD);
    assert_int_equal(info.active_nodes, hybrid->awake_count);
    move(&s, tool, 0.5, -0.6, 40);
    move(&s, tool, 0.5, -0.6, 200);
    assert_int_equal(hybrid->awake_count, 0);
    assert_int_equal(hybrid->point_count, 0);
    assert_int_equal(hybrid->drifting_count, 0);
    assert_near(largest_displacement(&s), 0.0, 2e-3);
    setup_fini(&s);
}

/* Slowly along the block, the force with particles that wake and sleep is that of all awake within
 * the 5 % that their number costs, and moves as smoothly. */
TEST(switching_is_not_felt)
{
    SKIP_WHERE_REPEATED();
    enum { STOPS = 30 };
    double force[2][STOPS];
    for (int all = 0; all < 2; ++all) {
        setup s;
        ss_model_tool tool[SOFTSIM_MAX_PROBES];
        init_block(&s, 300);
        if (all) {
            wake_all(&s);
        }
        (void)start_hybrid(&s);
        start_tool(tool, 0.35);
        move(&s, tool, 0.35, 0.1, 60);
        move(&s, tool, 0.35, 0.1, 60);
        for (int k = 0; k < STOPS; ++k) {
            move(&s, tool, 0.35 + 0.01 * (k + 1), 0.1, 12);
            force[all][k] = felt(&s);
        }
        setup_fini(&s);
    }
    for (int k = 0; k < STOPS; ++k) {
        assert_near(force[0][k] / force[1][k], 1.0, 0.05);
        if (k > 0) {
            const double jump = (force[0][k] - force[0][k - 1]) - (force[1][k] - force[1][k - 1]);
            assert_near(jump / force[1][k], 0.0, 0.02);
        }
    }
}

/* omega^2 of the contact by power iteration, 1/s^2: its nodes' masses and exact tangent. */
static double contact_rate2(ss_body *body)
{
    const ss_body_nodes *nodes = &body->nodes;
    const size_t count = 4 * (size_t)nodes->padded_count;
    ss_real *x = aligned_alloc(64, count * sizeof *x);
    ss_real *y = aligned_alloc(64, count * sizeof *y);
    double rate2 = 0.0;
    for (size_t k = 0; k < count; ++k) {
        x[k] = nodes->mobility[k] > 0 ? (ss_real)(1 + k % 7) : 0;
    }
    for (int turn = 0; turn < 60; ++turn) {
        double square = 0.0;
        double quotient = 0.0;
        memset(y, 0, count * sizeof *y);
        ss_body_contact_tangent(body, x, y);
        for (size_t k = 0; k < count; ++k) {
            const double light = (double)nodes->mobility[k];
            square += light > 0.0 ? (double)x[k] * (double)x[k] / light : 0.0;
            quotient += (double)x[k] * (double)y[k];
        }
        rate2 = quotient / square;
        for (size_t k = 0; k < count; ++k) {
            x[k] = (ss_real)((double)y[k] * (double)nodes->mobility[k] / rate2);
        }
    }
    free(x);
    free(y);
    return rate2;
}

/* What sub-steps are taken by holds for the contact at every depth and costs little more; and they
 * are as long as the two shares let them be. */
TEST(contact_bounds_the_substeps)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    ss_body *body = start_block(&s, 150)->body;
    start_tool(tool, 0.5);
    for (int k = 1; k <= 6; ++k) {
        move(&s, tool, 0.5, 0.025 * k, 20);
        move(&s, tool, 0.5, 0.025 * k, 10);
        const double exact = contact_rate2(body);
        assert_true(exact > 0.0 && body->contact_rate2 >= 0.999 * exact);
        assert_true(body->contact_rate2 < 2.5 * exact);
        const double law2 = 4.0 / (body->law_step * body->law_step);
        const double shared2 = law2 / 0.25 + body->contact_rate2 / 0.81;
        assert_near(body->longest * sqrt(shared2), 2.0, 1e-6);
        assert_near(body->bound * sqrt(law2 + body->contact_rate2), 2.0, 1e-6);
    }
    setup_fini(&s);
}

/* However many nodes of a fine core the particles of a skin node are tied to, it rides as soon as
 * one of them is awake, by a whole row. */
TEST(rows_have_room)
{
    setup s;
    setup_hybrid(&s, make_bar((const int[3]){16, 16, 10}, 0.0625, origin, 0.2, is_below_4), 0.15);
    give_row(&s, SS_HYBRID_MAX_ACTIVE, 1);
    ss_hybrid *hybrid = start_hybrid(&s);
    for (int32_t skin = 0; skin < hybrid->layer->skin_count; skin += 3) {
        ss_hybrid_wake_around(hybrid, skin);
        assert_true(hybrid->riding_count > 0);
        for (int32_t k = 0; k < hybrid->riding_count; ++k) {
            const ss_hybrid_ride *ride = &hybrid->ride[hybrid->riding[k]];
            double sum = 0.0;
            for (int32_t i = 0; i < ride->count; ++i) {
                sum += (double)ride->weight[i];
            }
            assert_near(sum, 1.0, 1e-4);
        }
        ss_hybrid_reset_layer(hybrid);
    }
    setup_fini(&s);
}

/* Nodes that take contact are where they are shown, also far from the tool, at the corners of
 * triangles that are much longer than most, and asleep. */
TEST(touched_skin_is_laid)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    ss_mesh *mesh = make_bar((const int[3]){30, 4, 4}, 0.2, origin, 0.0, is_below_2);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        double *x = mesh->position[i];
        x[0] = x[0] > 5.7 ? 5.6 + 10.0 * (x[0] - 5.6) : x[0];
    }
    setup_hybrid(&s, mesh, 0.08);
    give_row(&s, SS_HYBRID_MAX_ACTIVE, 1);
    s.plan.tool[0].is_used = true;
    s.plan.tool[0].shape = (ss_shape){.kind = SS_SHAPE_SPHERE, .radius = 0.25};
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        s.fixed[i] = mesh->position[i][2] == 0.0 ? 7 : 0;
    }
    ss_hybrid *hybrid = start_hybrid(&s);
    ss_body *body = hybrid->body;
    start_tool(tool, 8.6);
    for (int k = 0; k < 40; ++k) {
        move(&s, tool, 8.6, 0.02 * fmin(k / 10.0, 3.0), 1);
        const int32_t *node;
        const int32_t count = ss_contact_query_candidate_nodes(body->tools.tool[0].query, &node);
        const ss_real *shown = s.class->displacement(s.model);
        ss_contact_query_diagonal(body->tools.tool[0].query, body->skin_stiff);
        for (int32_t i = 0; i < count; ++i) {
            for (int a = 0; a < 3 && body->skin_stiff[node[i]] > 0.0; ++a) {
                const ptrdiff_t at = 4 * (ptrdiff_t)node[i] + a;
                assert_near((double)body->skin_u[at], (double)shown[at], 1e-7);
            }
            body->skin_stiff[node[i]] = 0.0;
        }
    }
    assert_true(body->tools.tool[0].penalty > 0.0);
    setup_fini(&s);
}

static uint64_t press_and_hash(setup *s)
{
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    start_tool(tool, 0.4);
    move(s, tool, 0.4, 0.1, 30);
    move(s, tool, 0.6, 0.1, 30);
    move(s, tool, 0.6, -0.6, 10);
    return hash_of(s);
}

/* After a fault the body stays as it was, and so does its surface wherever a tool goes. */
TEST(a_fault_freezes_the_surface)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    ss_hybrid *hybrid = start_block(&s, 150);
    start_tool(tool, 0.3);
    move(&s, tool, 0.3, 0.1, 30);
    const size_t size = 4 * (size_t)s.mesh->node_count * sizeof(ss_real);
    ss_real *frozen = malloc(size);
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        nodes->v[4 * (ptrdiff_t)i] = nodes->mass[i] > 0.0 ? (ss_real)NAN : nodes->v[4 * i];
    }
    move(&s, tool, 0.3, 0.1, 1);
    assert_true((info_of(&s).fault_bits & SS_MODEL_FAULT_NOT_FINITE) != 0);
    memcpy(frozen, s.class->displacement(s.model), size);
    move(&s, tool, 0.7, 0.1, 30);
    move(&s, tool, 0.7, -1.0, 60);
    assert_memory_equal(frozen, s.class->displacement(s.model), size);
    free(frozen);
    setup_fini(&s);
}

/* Ends the setup. */
static bool warns(setup *s, const char *where)
{
    (void)start_hybrid(s);
    const int count = note_count(s->class, s->model, SS_NOTE_WARNING, where, "");
    setup_fini(s);
    return count > 0;
}

TEST(what_makes_results_worse_is_told)
{
    for (int k = 0; k < 2; ++k) {
        setup s;
        init_block(&s, 150);
        give_row(&s, SS_FEM_LAMBDA, k == 0 ? 5.5 : 60.0); /* Poisson's ratio: 0.34, 0.48 */
        assert_true(warns(&s, "model.poisson_ratio") == (k == 1));
        /* Elements of an eighth of the layer's thickness, where usual ones have about all of it. */
        if (k == 0) {
            init_block(&s, 150);
        } else {
            setup_hybrid(&s, make_bar((const int[3]){16, 16, 10}, 0.0625, origin, 0.2, is_below_4),
                         0.15);
        }
        assert_true(warns(&s, "model.layer") == (k == 1));
    }
}

TEST(reset_begins_anew)
{
    setup s;
    (void)start_block(&s, 100);
    const uint64_t first = press_and_hash(&s);
    s.class->reset(s.model);
    assert_near(largest_displacement(&s), 0.0, 0.0);
    s.class->reset(s.model);
    const uint64_t again = press_and_hash(&s);
    setup_fini(&s);
    (void)start_block(&s, 100);
    assert_true(press_and_hash(&s) == first);
    setup_fini(&s);
    assert_true(first == again);
}

/* A node far too fast goes a fifth of the finest edge in a sub-step, be it the core's or the finest
 * spacing of a layer that also has coarser ones. */
TEST(fast_nodes_keep_within_an_edge)
{
    SKIP_WHERE_REPEATED();
    for (int is_fine_core = 0; is_fine_core < 2; ++is_fine_core) {
        setup s;
        ss_model_info info;
        const double h = is_fine_core ? 0.05 : 0.2;
        setup_hybrid(&s, make_bar((const int[3]){6, 6, 4}, h, origin, 0.0, is_below_2), 0.4 * h);
        double *spacing = calloc((size_t)s.mesh->node_count, sizeof *spacing);
        for (int32_t i = 0; i < s.mesh->node_count; ++i) {
            spacing[i] = is_fine_core ? 0.09 : s.mesh->position[i][0] < 0.6 ? 0.035 : 0.14;
        }
        s.param[SS_HYBRID_SPACING].per_node = spacing;
        const double finest = is_fine_core ? ss_body_mean_edge(s.mesh) : 0.035;
        const int32_t fast = s.mesh->node_count / 8;
        ss_hybrid *hybrid = start_hybrid(&s);
        const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
        nodes->v[4 * (ptrdiff_t)fast] = 1000;
        s.class->step(s.model, 0.0, 1e-4, NULL);
        s.class->info(s.model, &info);
        assert_int_equal(info.substeps, 1);
        assert_true(nodes->u[4 * (ptrdiff_t)fast] > 0);
        assert_true((double)nodes->u[4 * (ptrdiff_t)fast] < 0.201 * finest);
        free(spacing);
        setup_fini(&s);
    }
}

/* A number that is not finite is a fault until reset, with either integrator, and none after. */
TEST(fault_ends_with_reset)
{
    for (int integrator = 0; integrator < 2; ++integrator) {
        setup s;
        ss_model_tool tool[SOFTSIM_MAX_PROBES];
        ss_model_info info;
        init_block(&s, 100);
        give_row(&s, SS_FEM_INTEGRATOR, integrator);
        ss_hybrid *hybrid = start_hybrid(&s);
        const uint64_t first = press_and_hash(&s);
        s.class->reset(s.model);
        start_tool(tool, 0.5);
        move(&s, tool, 0.5, 0.1, 30);
        assert_true(hybrid->point_count > 100);
        for (int32_t i = 0; i < 10; ++i) { /* of particles, so that points see it */
            ss_body_get_nodes(hybrid->body)->v[4 * (ptrdiff_t)(s.mesh->node_count + i)] =
                (ss_real)INFINITY;
        }
        move(&s, tool, 0.5, 0.1, 1);
        s.class->info(s.model, &info);
        assert_int_equal(info.verdict, SOFTSIM_VERDICT_FAULT);
        s.class->reset(s.model);
        const uint64_t again = press_and_hash(&s);
        s.class->info(s.model, &info);
        assert_true(info.verdict < SOFTSIM_VERDICT_FAULT);
        assert_true(first == again);
        setup_fini(&s);
    }
}

/* A blow far too hard: finite, told, and back to rest. */
TEST(hard_blow_is_survived)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    (void)start_block(&s, 100);
    start_tool(tool, 0.5);
    move(&s, tool, 0.5, 0.6, 3);
    move(&s, tool, 0.5, 0.6, 20);
    const ss_real *u = s.class->displacement(s.model);
    for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)s.mesh->node_count; ++k) {
        assert_true(isfinite(u[k]));
    }
    move(&s, tool, 0.5, -0.6, 10);
    move(&s, tool, 0.5, -0.6, 300);
    assert_near(largest_displacement(&s), 0.0, 0.01);
    setup_fini(&s);
}

/* A corner of the core is taken through the node across its cell. */
TEST(a_core_turned_inside_out_is_told)
{
    setup s;
    int32_t node[1] = {0};
    double way[1][3] = {{0.4, 0.4, 0.4}};
    const ss_prescribed set = {.node = node,
                               .node_count = 1,
                               .displacement = way,
                               .axis = {true, true, true},
                               .ramp = 0.2};
    setup_hybrid(&s, make_bar((const int[3]){4, 4, 4}, 0.25, origin, 0.0, is_below_2), 0.1);
    for (int32_t i = 1; i < s.mesh->node_count; ++i) {
        s.fixed[i] = 7;
    }
    s.plan.prescribed = &set;
    s.plan.prescribed_count = 1;
    (void)start_hybrid(&s);
    steps(&s, 2, 0.01);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
    steps(&s, 40, 0.01);
    const ss_model_info info = info_of(&s);
    assert_int_equal(info.verdict, SOFTSIM_VERDICT_DEGRADED);
    assert_non_null(strstr(info.reason, "inside out"));
    const int32_t *c = s.mesh->tetrahedron[info.worst_element];
    assert_true(c[0] == 0 || c[1] == 0 || c[2] == 0 || c[3] == 0);
    s.class->reset(s.model);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
    setup_fini(&s);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
