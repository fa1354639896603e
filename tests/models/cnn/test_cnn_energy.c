/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * cnn-energy without tools: closed forms, invariants, one equilibrium, the published behaviour of
 * a cylinder. Tolerances are given for single and double precision.
 */
#include "common/test.h"

#include "common/effort.h"
#include "common/element_fixture.h"
#include "rt/thread.h"

/* ---- the hexagon fan ---- */

/* z'' = (F - gamma z' - ks z - 0.75 E z^3 / h^2) / m, integrated finely: the model's closed form.
 */
static double duffing(double z[2], double e, double m, double gamma, double ks, double f, double dt)
{
    enum { PARTS = 20 };
    const double h = dt / PARTS, cubic = 0.75 * e / (FAN_EDGE * FAN_EDGE);
    for (int part = 0; part < PARTS; ++part) {
        double x = z[0], v = z[1], k[4], w[4];
        for (int s = 0; s < 4; ++s) {
            w[s] = v;
            k[s] = (f - gamma * v - ks * x - cubic * x * x * x) / m;
            const double step = s < 2 ? 0.5 * h : h;
            x = z[0] + step * w[s];
            v = z[1] + step * k[s];
        }
        z[0] += h / 6.0 * (w[0] + 2.0 * w[1] + 2.0 * w[2] + w[3]);
        z[1] += h / 6.0 * (k[0] + 2.0 * k[1] + 2.0 * k[2] + k[3]);
    }
    return z[0];
}

TEST(the_hexagon_fan_is_exactly_the_duffing_oscillator)
{
    static const double direction[3][3] = {{0, 0, 1}, {1, 0, 0}, {0.48, -0.6, 0.64}};
    for (int d = 0; d < 3; ++d) {
        setup s;
        int32_t centre = 0;
        setup_fan(&s, 7.0, 1.0, 0.5, 0.3);
        push(&s, &centre, 0.25 * direction[d][0], 0.25 * direction[d][1], 0.25 * direction[d][2]);
        create(&s);
        double z[2] = {0.0, 0.0};
        for (int k = 0; k < 1000; ++k) {
            duffing(z, 7.0, 1.0, 0.5, 0.3, 0.25, 0.01);
            steps(&s, 1, 0.01);
            for (int axis = 0; axis < 3; ++axis) {
                assert_near(moved(&s, 0, axis), z[0] * direction[d][axis], BY_TYPE(2e-7, 2e-9));
            }
        }
        assert_near(energy_gain(&s), 0.0, BY_TYPE(2e-8, 1e-9));
        setup_fini(&s);
    }
}

TEST(a_saturated_fan_carries_the_rest_by_its_springs)
{
    for (int kind = 0; kind < 2; ++kind) {
        setup s;
        int32_t centre = 0;
        setup_fan(&s, 60.0, 1.0, 2.0, 0.3);
        if (kind == 1) { /* the same body by its energy: E^ = E Qhat, Qhat = 1.5 h^2 */
            s.param[row_of(&s, "modulus_n_per_m")].is_given = false;
            give(&s, "modulus_j", 60.0 * 1.5 * FAN_EDGE * FAN_EDGE);
        }
        give(&s, "saturation", 0.2);
        push(&s, &centre, 0.0, 0.0, 0.5);
        create(&s);
        steps(&s, 20000, 0.02);
        const double expected = 0.5 / (0.3 + 6.0 * 0.05 * 0.2 / (FAN_EDGE * FAN_EDGE));
        assert_near(moved(&s, 0, 2), expected, BY_TYPE(1e-6, 1e-12));
        setup_fini(&s);
    }
}

TEST(pretension_adds_its_stiffness_to_the_fan)
{
    setup s;
    int32_t centre = 0;
    const double pretension = 0.05, ks = 0.3 + pretension / (FAN_EDGE * FAN_EDGE);
    setup_fan(&s, 7.0, 1.0, 0.5, 0.3);
    give(&s, "pretension_j", pretension);
    push(&s, &centre, 0.0, 0.0, 0.25);
    create(&s);
    double z[2] = {0.0, 0.0};
    for (int k = 0; k < 500; ++k) {
        duffing(z, 7.0, 1.0, 0.5, ks, 0.25, 0.01);
        steps(&s, 1, 0.01);
        assert_near(moved(&s, 0, 2), z[0], BY_TYPE(2e-7, 2e-9));
    }
    setup_fini(&s);
}

TEST(a_prescribed_node_reports_the_force_that_it_takes)
{
    setup s;
    int32_t centre = 0;
    double way[1][3] = {{0.0, 0.0, -0.1}};
    setup_fan(&s, 7.0, 1.0, 0.5, 0.3);
    prescribe(&s, 1, &centre, way, 1.0);
    create(&s);
    steps(&s, 500, 0.01);
    assert_near(moved(&s, 0, 2), -0.1, BY_TYPE(1e-8, 1e-15));
    double reaction[3];
    s.class->reaction(s.model, 0, reaction);
    const double force = 0.3 * 0.1 + 0.75 * 7.0 * 1e-3 / (FAN_EDGE * FAN_EDGE);
    assert_near(reaction[2], -force, BY_TYPE(1e-6, 1e-12));
    s.class->reaction(s.model, -1, reaction); /* the rim holds what the springs do not */
    assert_near(reaction[2], force - 0.3 * 0.1, BY_TYPE(1e-6, 1e-12));
    assert_near(energy_gain(&s), 0.0, BY_TYPE(1e-7, 1e-12));
    setup_fini(&s);
}

TEST(an_axis_that_is_fixed_alone_stays_and_the_others_move)
{
    setup s;
    int32_t centre = 0;
    setup_fan(&s, 7.0, 1.0, 0.5, 0.3);
    s.fixed[0] = 2;
    push(&s, &centre, 0.1, 0.2, 0.3);
    create(&s);
    steps(&s, 3000, 0.02);
    assert_true(moved(&s, 0, 1) == 0.0);
    const double x = moved(&s, 0, 0), z = moved(&s, 0, 2);
    assert_near(z / x, 3.0, 1e-3);
    assert_true(x > 0.01);
    double reaction[3];
    s.class->reaction(s.model, -1, reaction);
    assert_near(reaction[1], -0.2, BY_TYPE(1e-6, 1e-12));
    setup_fini(&s);
}

/* ---- rho ---- */

/* Largest difference of two bodies' displacements over the largest displacement. */
static double difference(const setup *a, const setup *b)
{
    double largest = 0.0;
    for (int32_t i = 0; i < a->mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            largest = fmax(largest, fabs(moved(a, i, k) - moved(b, i, k)));
        }
    }
    return largest / largest_displacement(a);
}

static void run_rho(setup *s, double rho, double saturation)
{
    static int32_t top;
    setup_body(s, 4);
    top = top_node(s->mesh);
    give(s, "rho", rho);
    if (saturation > 0.0) {
        give(s, "saturation", saturation);
    }
    push(s, &top, 0.2, 0.0, 0.6);
    create(s);
    steps(s, 400, 0.05);
}

TEST(uniform_rho_cancels)
{
    setup a, b;
    run_rho(&a, 0.05, 0.0);
    run_rho(&b, 50.0, 0.0);
    assert_true(largest_displacement(&a) > 0.1);
    assert_true(difference(&a, &b) <= BY_TYPE(1e-5, 1e-12));
    setup_fini(&a);
    setup_fini(&b);
}

TEST(doubling_rho_equals_doubling_the_saturation)
{
    setup a, b, c;
    run_rho(&a, 0.05, 0.2);
    run_rho(&b, 0.1, 0.1);
    run_rho(&c, 0.05, 0.0);
    assert_true(difference(&a, &b) <= BY_TYPE(1e-5, 1e-12));
    assert_true(difference(&a, &c) > 0.05); /* it does saturate */
    setup_fini(&a);
    setup_fini(&b);
    setup_fini(&c);
}

/* ---- invariance ---- */

/* The body of `from` turned, shifted, renumbered (i -> (i * 7 + 3) mod n) and wound the other way.
 */
static ss_mesh *changed_mesh(const ss_mesh *from, const double q[4], const double shift[3],
                             bool is_renumbered, bool is_flipped)
{
    draft d;
    const int32_t n = from->node_count;
    draft_init(&d, n, from->triangle_count);
    d.nodes = n;
    for (int32_t i = 0; i < n; ++i) {
        const int32_t to = is_renumbered ? (i * 7 + 3) % n : i;
        ss_rotate(d.position[to], q, from->position[i]);
        ss_add3(d.position[to], d.position[to], shift);
    }
    for (int32_t t = 0; t < from->triangle_count; ++t) {
        int32_t c[3];
        for (int k = 0; k < 3; ++k) {
            const int32_t i = from->triangle[t][k];
            c[k] = is_renumbered ? (i * 7 + 3) % n : i;
        }
        draft_triangle(&d, c[0], c[is_flipped ? 2 : 1], c[is_flipped ? 1 : 2]);
    }
    return draft_finish(&d);
}

static void compare_changed(bool is_free, bool is_renumbered, bool is_flipped, double tolerance)
{
    const double q[4] = {0.8, 0.36, -0.48, 0.0}, shift[3] = {3.0, -7.0, 11.0};
    setup a, b;
    int32_t node_a, node_b;
    for (int which = 0; which < 2; ++which) {
        setup *s = which == 0 ? &a : &b;
        setup_body(s, 4);
        int32_t *node = which == 0 ? &node_a : &node_b;
        *node = top_node(s->mesh);
        const int32_t n = s->mesh->node_count;
        uint8_t *fixed = calloc((size_t)n, 1);
        double force[3] = {0.2, 0.1, 0.6}, turned[3];
        ss_copy3(turned, force);
        for (int32_t i = 0; i < n; ++i) {
            const int32_t to = which == 1 && is_renumbered ? (i * 7 + 3) % n : i;
            fixed[to] = is_free ? 0 : s->fixed[i];
        }
        if (which == 1) {
            ss_mesh *mesh = changed_mesh(s->mesh, q, shift, is_renumbered, is_flipped);
            ss_mesh_destroy(&s->mesh);
            s->mesh = mesh;
            s->plan.mesh = mesh;
            *node = is_renumbered ? (*node * 7 + 3) % n : *node;
            ss_rotate(turned, q, force);
        }
        memcpy(s->fixed, fixed, (size_t)n);
        free(fixed);
        push(s, node, turned[0], turned[1], turned[2]);
        create(s);
        steps(s, 200, 0.05);
    }
    double worst = 0.0;
    const int32_t n = a.mesh->node_count;
    for (int32_t i = 0; i < n; ++i) {
        const int32_t to = is_renumbered ? (i * 7 + 3) % n : i;
        const double u[3] = {moved(&a, i, 0), moved(&a, i, 1), moved(&a, i, 2)};
        double turned[3];
        ss_rotate(turned, q, u);
        for (int k = 0; k < 3; ++k) {
            worst = fmax(worst, fabs(turned[k] - moved(&b, to, k)));
        }
    }
    assert_near(worst / largest_displacement(&a), 0.0, tolerance);
    setup_fini(&a);
    setup_fini(&b);
}

TEST(place_numbering_and_winding_do_not_matter)
{
    for (int is_free = 0; is_free < 2; ++is_free) {
        compare_changed(is_free != 0, false, false, BY_TYPE(2e-5, 1e-11));
        compare_changed(is_free != 0, true, false, BY_TYPE(2e-5, 1e-11));
        compare_changed(is_free != 0, false, true, BY_TYPE(2e-5, 1e-11));
    }
}

TEST(a_free_body_gains_the_momentum_it_is_given)
{
    setup s;
    setup_body(&s, 4);
    memset(s.fixed, 0, (size_t)s.mesh->node_count);
    per_node(&s, 1.0, 0.0, 0.1);
    int32_t top = top_node(s.mesh);
    push(&s, &top, 0.2, -0.1, 0.6);
    create(&s);
    steps(&s, 400, 0.05);
    double momentum[3] = {0.0, 0.0, 0.0};
    const ss_real *v = s.class->velocity(s.model);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            momentum[k] += (double)v[4 * i + k];
        }
    }
    assert_near(momentum[0], 0.2 * s.time, BY_TYPE(1e-4, 1e-11));
    assert_near(momentum[1], -0.1 * s.time, BY_TYPE(1e-4, 1e-11));
    assert_near(momentum[2], 0.6 * s.time, BY_TYPE(1e-4, 1e-11));
    assert_near(energy_gain(&s), 0.0, 1e-3 * info_of(&s).work);
    setup_fini(&s);
}

/* ---- one potential, one equilibrium ---- */

TEST(network_forces_are_the_gradient_of_the_potential)
{
    /* plain; two sources, saturated; T0 and B; free; hinged: fixed, yet free to turn */
    for (int kind = 0; kind < 5; ++kind) {
        setup s;
        setup_body(&s, 3);
        int32_t top = top_node(s.mesh), other = 5;
        const int32_t hinge = 30;
        push(&s, &top, 0.0, 0.0, 0.1);
        if (kind == 1) {
            push(&s, &other, 0.0, 0.0, 0.1);
            give(&s, "saturation", 0.05);
        }
        if (kind == 2) {
            give(&s, "pretension_j", 3.0);
            give(&s, "enclosed_bulk_pa", 2.0);
        }
        if (kind >= 3) {
            memset(s.fixed, 0, (size_t)s.mesh->node_count);
        }
        if (kind == 4) {
            s.fixed[hinge] = s.fixed[hinge + 1] = 7;
        }
        create(&s);
        random_state = 10u + (uint64_t)kind;
        check_network_gradient(&s, 0.15);
        setup_fini(&s);
    }
}

TEST(each_load_has_one_equilibrium)
{
    setup a, b;
    int32_t top;
    for (int which = 0; which < 2; ++which) {
        setup *s = which == 0 ? &a : &b;
        setup_body(s, 4);
        top = top_node(s->mesh);
        push(s, &top, 0.1, 0.0, -0.8);
        create(s);
        random_state = 77;
        if (which == 1) {
            crumple(s, 0.4);
        }
        steps(s, 6000, 0.1);
    }
    assert_true(difference(&a, &b) < BY_TYPE(2e-6, 1e-11));
    setup_fini(&a);
    setup_fini(&b);
}

TEST(a_crumpled_body_returns_to_rest)
{
    for (int kind = 0; kind < 2; ++kind) {
        setup s;
        setup_body(&s, 4);
        int32_t top = top_node(s.mesh);
        push(&s, &top, 0.0, 0.0, -1.0);
        s.load[0].to = 30.0; /* the source stays on when the force has gone */
        if (kind == 1) {     /* soft springs and a stiff network: where dents could stay */
            give(&s, "modulus_n_per_m", 4.0);
            per_node(&s, 1.0, 2.0, 0.3);
        }
        create(&s);
        random_state = 5;
        crumple(&s, 0.5);
        steps(&s, 300, 0.1);
        assert_true(largest_displacement(&s) > 0.1);
        steps(&s, 6000, 0.1);
        assert_near(largest_displacement(&s), 0.0, BY_TYPE(1e-9, 1e-10));
        setup_fini(&s);
    }
}

static double static_depth(double mass, double damping, double dt, int count)
{
    setup s;
    setup_body(&s, 3);
    per_node(&s, mass, damping, 0.1);
    int32_t top = top_node(s.mesh);
    push(&s, &top, 0.0, 0.0, -0.8);
    create(&s);
    steps(&s, count, dt);
    const double depth = moved(&s, top, 2);
    setup_fini(&s);
    return depth;
}

TEST(the_equilibrium_does_not_depend_on_mass_damping_or_step)
{
    const double depth = static_depth(1.0, 2.0, 0.1, 6000);
    assert_true(depth < -0.3);
    assert_near(static_depth(1.0, 2.0, 0.04, 15000) / depth, 1.0, BY_TYPE(1e-6, 1e-10));
    assert_near(static_depth(0.2, 2.0, 0.1, 6000) / depth, 1.0, BY_TYPE(1e-6, 1e-10));
    assert_near(static_depth(1.0, 5.0, 0.2, 9000) / depth, 1.0, BY_TYPE(1e-6, 1e-10));
}

TEST(a_refined_body_behaves_the_same_per_area)
{
    double depth[2];
    for (int k = 0; k < 2; ++k) {
        setup s;
        setup_body(&s, k == 0 ? 6 : 9);
        for (int r = SS_CNN_PER_AREA; r <= SS_CNN_REST_STIFFNESS; ++r) {
            s.param[r].is_given = false;
            s.param[r].number = s.class->row[r].fallback;
        }
        s.param[SS_CNN_MODULUS_N_PER_M].is_given = false;
        give(&s, "modulus_j", 5.0);
        give(&s, "pretension_j", 2.0);
        give(&s, "area_density_kg_m2", 40.0);
        give(&s, "damping_n_s_per_m3", 80.0);
        give(&s, "rest_stiffness_n_per_m3", 4.0);
        /* The same patch of the surface on both meshes. */
        int32_t patch[400], count = 0;
        for (int32_t i = 0; i < s.mesh->node_count && count < 400; ++i) {
            if (s.mesh->position[i][2] > 0.7) {
                patch[count++] = i;
            }
        }
        s.load[0] = (ss_load){
            .node = patch, .node_count = count, .force = {0, 0, -2.0}, .to = (double)INFINITY};
        s.plan.load_count = 1;
        create(&s);
        steps(&s, 1500, 0.1);
        depth[k] = moved(&s, top_node(s.mesh), 2);
        setup_fini(&s);
    }
    assert_true(depth[0] < -0.01);
    assert_near(depth[1] / depth[0], 1.0, 0.1);
}

/* ---- the published cylinder, as a rectangular grid and as triangles ---- */

TEST(the_cylinder_hardens_with_load)
{
    SKIP_WHERE_REPEATED();
    static const double force[7] = {0.01, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0};
    static const double grid[7] = {0.087, 0.332, 0.5193, 0.720, 0.994, 1.365, 1.863};
    for (int k = 0; k < 14; ++k) {
        /* Published for triangles: .5102 at .25, .972 at 1; this mesh's own at 4. */
        const double triangles[7] = {0.0, 0.0, 0.5102, 0.0, 0.972, 0.0, 1.82};
        const bool is_grid = k < 7;
        const double depth = is_grid ? grid[k] : triangles[k - 7];
        if (depth == 0.0) {
            continue;
        }
        setup s;
        int32_t top = TOP;
        setup_either_cylinder(&s, is_grid, 1.0);
        push(&s, &top, 0.0, -force[k % 7], 0.0);
        create(&s);
        steps(&s, 5000, 0.05);
        assert_near(-moved(&s, TOP, 1), depth, 0.005 * depth);
        setup_fini(&s);
    }
}

TEST(the_cylinder_creeps_in_the_order_of_its_damping)
{
    SKIP_WHERE_REPEATED();
    /* Published for the grid: 38 s and 123.5 s to 90 % of the depth after 400 s. */
    enum { COUNT = 2000 };
    static const double gamma[3] = {3.0, 6.0, 10.0};
    static const double t90[2][3] = {{38.0, 75.6, 123.5}, {36.1, 72.3, 118.1}};
    for (int k = 0; k < 6; ++k) {
        const bool is_grid = k < 3;
        setup s;
        int32_t top = TOP, reached = 0;
        double depth[COUNT];
        setup_either_cylinder(&s, is_grid, gamma[k % 3]);
        push(&s, &top, 0.0, -0.25, 0.0);
        create(&s);
        for (int n = 0; n < COUNT; ++n) {
            steps(&s, 1, 0.2);
            depth[n] = -moved(&s, TOP, 1);
            assert_true(n == 0 || depth[n] > depth[n - 1] - 1e-6); /* no overshoot */
        }
        while (depth[reached] < 0.9 * depth[COUNT - 1]) {
            ++reached;
        }
        assert_near(depth[COUNT - 1], is_grid ? 0.5193 : 0.5102, 0.003);
        assert_near(0.2 * (reached + 1), t90[k / 3][k % 3], 0.01 * t90[k / 3][k % 3]);
        setup_fini(&s);
    }
}

TEST(the_cylinder_yields_less_to_a_quick_ramp)
{
    static const double gamma[4] = {1.0, 4.0, 7.0, 10.0}, depth[4] = {0.709, 0.468, 0.383, 0.334};
    for (int k = 0; k < 4; ++k) {
        setup s;
        int32_t top = TOP;
        setup_either_cylinder(&s, true, gamma[k]);
        push(&s, &top, 0.0, -1.0, 0.0);
        s.load[0].ramp = 10.0;
        create(&s);
        steps(&s, 200, 0.05);
        assert_near(-moved(&s, TOP, 1), depth[k], 0.02 * depth[k]);
        setup_fini(&s);
    }
}

TEST(the_cylinder_shows_hysteresis_and_returns)
{
    SKIP_WHERE_REPEATED();
    /* Depths at F = .25 on the way up and down; of the triangles this mesh's own. */
    static const double gamma[4] = {2.0, 9.0, 2.0, 9.0}, area[4] = {0.113, 0.118, 0.106, 0.115};
    static const double loading[4] = {0.359, 0.203, 0.3625, 0.2081};
    static const double unloading[4] = {0.585, 0.444, 0.571, 0.444};
    for (int k = 0; k < 4; ++k) {
        setup s;
        int32_t top = TOP;
        setup_either_cylinder(&s, k < 2, gamma[k]);
        push(&s, &top, 0.0, -0.5, 0.0);
        push(&s, &top, 0.0, 0.5, 0.0); /* takes the first back; the same cells, one source */
        s.load[0].ramp = s.load[1].ramp = s.load[1].from = 40.0;
        create(&s);
        assert_int_equal(s.model->source_count, 1);
        double loop = 0.0, last_force = 0.0, last_depth = 0.0;
        for (int n = 1; n <= 1600; ++n) {
            steps(&s, 1, 0.05);
            const double force = s.time < 40.0 ? 0.5 * s.time / 40.0 : 0.5 * (2.0 - s.time / 40.0);
            const double depth = -moved(&s, TOP, 1);
            loop += 0.5 * (force + last_force) * (depth - last_depth);
            last_force = force;
            last_depth = depth;
            if (n == 400) {
                assert_near(depth, loading[k], 0.02 * loading[k]);
            }
            if (n == 1200) {
                assert_near(depth, unloading[k], 0.02 * unloading[k]);
            }
        }
        assert_near(loop, area[k], 0.02 * area[k]);
        if (k % 2 == 0) {
            steps(&s, 4000, 0.1);
            assert_near(largest_displacement(&s), 0.0, 1e-9);
        }
        setup_fini(&s);
    }
}

/* Depth of the pushed point, width of its ring and the largest motion beyond |z| > 0.6, at F = 1.
 */
typedef struct dent {
    double depth, width, far;
} dent;

static dent dent_of(setup *s)
{
    int32_t top = TOP;
    dent out = {0.0, 0.0, 0.0};
    push(s, &top, 0.0, -1.0, 0.0);
    create(s);
    steps(s, 6000, 0.05);
    out.depth = -moved(s, TOP, 1);
    out.width = 2.0 + moved(s, LEFT, 0) - moved(s, RIGHT, 0);
    for (int32_t i = 0; i < 360; ++i) {
        for (int k = 0; fabs(s->mesh->position[i][2]) > 0.6 && k < 3; ++k) {
            out.far = fmax(out.far, fabs(moved(s, i, k)));
        }
    }
    setup_fini(s);
    return out;
}

TEST(the_cylinder_follows_its_directions)
{
    SKIP_WHERE_REPEATED();
    /* rho along the axis and around it; published depth and width, grid then triangles. */
    static const struct {
        double axial, ring, depth[2], width[2];
    } row[3] = {{0.05, 0.05, {0.994, 0.972}, {1.905, 1.928}},
                {0.05, 0.1, {1.042, 1.031}, {1.866, 1.907}},
                {0.1, 0.05, {0.946, 0.934}, {1.939, 1.949}}};
    for (int k = 0; k < 6; ++k) {
        const bool is_grid = k % 2 == 0;
        setup s;
        setup_either_cylinder(&s, is_grid, 1.0);
        s.param[SS_CNN_RHO].is_given = false;
        give(&s, "rho_direction", row[k / 2].axial);
        give(&s, "rho_across", row[k / 2].ring);
        if (!is_grid) {
            give_direction(&s, 0.0, 0.0, 1.0);
        }
        const dent got = dent_of(&s);
        assert_near(got.depth, row[k / 2].depth[k % 2], 0.002);
        assert_near(got.width, row[k / 2].width[k % 2], 0.002);
    }
}

TEST(the_cylinder_differs_by_its_bands)
{
    /* Published for bands of .05 and .1, whose places are not told: here two rings each, the
     * pushed ring in a band of .1. */
    static const double depth[2] = {1.037, 1.015};
    for (int k = 0; k < 2; ++k) {
        setup s;
        double rho[360];
        setup_either_cylinder(&s, k == 0, 1.0);
        for (int32_t i = 0; i < 360; ++i) {
            rho[i] = i / 24 % 4 < 2 ? 0.05 : 0.1;
        }
        give_field(&s, "rho", rho);
        assert_near(dent_of(&s).depth, depth[k], 0.01 * depth[k]);
    }
}

TEST(a_region_of_tiny_rho_stays_still)
{
    for (int k = 0; k < 3; ++k) { /* grid, triangles, grid with two tiny rho */
        setup s;
        double rho[360];
        setup_either_cylinder(&s, k != 1, 1.0);
        for (int32_t i = 0; i < 360; ++i) {
            rho[i] = fabs(s.mesh->position[i][2]) > 0.6 ? 1e-6 : 0.05;
        }
        if (k == 2) {
            s.param[SS_CNN_RHO].is_given = false;
            give_field(&s, "rho_direction", rho);
            give_field(&s, "rho_across", rho);
        } else {
            give_field(&s, "rho", rho);
        }
        const dent got = dent_of(&s);
        assert_true(got.depth > 0.5);
        assert_true(got.far > 0.0 && got.far <= 4.5e-5);
    }
}

int main(void)
{
    ss_thread_flush_denormals();
    return run_all_tests(NULL, NULL);
}
