/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Bodies on rectangular grids, with a material direction and with cells inside: invariance, one
 * potential, the step bound; volumes under loads and tools.
 */
#include "common/test.h"

#include "common/effort.h"
#include "common/element_fixture.h"
#include "rt/thread.h"

/* ---- bodies ---- */

enum {
    BODY_GRID,
    BODY_GRID_DIRECTED,
    BODY_TRIANGLES_DIRECTED,
    BODY_VOLUME,
    BODY_VOLUME_DIRECTED,
    BODY_KINDS
};

/* Where a body is: turned by q, shifted, its nodes renumbered i -> (7 i + 3) mod n and its
 * elements in reverse order. */
typedef struct change {
    double q[4], shift[3];
    bool is_renumbered;
} change;

static int32_t renumber(const change *by, int32_t i, int32_t n)
{
    return by->is_renumbered ? (i * 7 + 3) % n : i;
}

/* Elements of `corners` nodes, renumbered. */
static int32_t *changed_elements(const change *by, const int32_t *node, int32_t count, int corners,
                                 int32_t n)
{
    int32_t *out = ss_memory_get((size_t)(count * corners), sizeof *out);
    for (int32_t k = 0; k < count * corners; ++k) {
        const int32_t e = by->is_renumbered ? count - 1 - k / corners : k / corners;
        out[k] = renumber(by, node[e * corners + k % corners], n);
    }
    return out;
}

static ss_mesh *changed_mesh(const ss_mesh *from, const change *by)
{
    const int32_t n = from->node_count;
    double(*position)[3] = calloc((size_t)n, sizeof *position);
    ss_mesh *mesh = NULL;
    for (int32_t i = 0; i < n; ++i) {
        double *p = position[renumber(by, i, n)];
        ss_rotate(p, by->q, from->position[i]);
        ss_add3(p, p, by->shift);
    }
    int32_t *triangle =
        changed_elements(by, (const int32_t *)from->triangle, from->triangle_count, 3, n);
    int32_t *tetrahedron =
        changed_elements(by, (const int32_t *)from->tetrahedron, from->tetrahedron_count, 4, n);
    (void)ss_mesh_create(n, (const double(*)[3])position, from->triangle_count,
                         (const int32_t(*)[3])triangle, from->tetrahedron_count,
                         (const int32_t(*)[4])tetrahedron, &mesh, NULL);
    mesh->quad_count = from->quad_count;
    mesh->quad = from->quad ? (int32_t(*)[4])changed_elements(by, (const int32_t *)from->quad,
                                                              from->quad_count, 4, n)
                            : NULL;
    free(position);
    ss_memory_free(triangle);
    ss_memory_free(tetrahedron);
    return mesh;
}

static void give_volume(setup *s)
{
    give(s, "domain", 1.0);
    give(s, "density_kg_m3", 1000.0);
    give(s, "damping_n_s_per_m4", 3000.0);
    give(s, "rest_stiffness_n_per_m4", 20.0);
}

/* A body of `kind` with the push on `*node`; held at its lower end unless free. */
static void setup_kind(setup *s, int kind, bool is_free, const change *by, int32_t *node)
{
    const bool is_volume = kind == BODY_VOLUME || kind == BODY_VOLUME_DIRECTED;
    ss_mesh *plain = is_volume                         ? make_block(4, 1.0)
                     : kind == BODY_TRIANGLES_DIRECTED ? make_cylinder(9, 16, 1.0, 2.0)
                                                       : make_grid_cylinder(9, 16, 1.0, 2.0);
    const double bottom = is_volume ? -0.49 : -0.99;
    double force[3] = {0.3, -0.2, 0.6};
    setup_init(s, "cnn-energy", changed_mesh(plain, by));
    for (int32_t i = 0; i < plain->node_count; ++i) {
        const bool is_fixed = !is_free && plain->position[i][2] < bottom;
        s->fixed[renumber(by, i, plain->node_count)] = is_fixed ? 7 : 0;
    }
    give(s, "modulus_j", 40.0);
    if (is_volume) {
        give_volume(s);
        ss_scale3(force, force, 20.0);
    } else {
        per_node(s, 1.0, 2.0, 0.3);
    }
    if (kind != BODY_VOLUME && kind != BODY_GRID) {
        const double along[3] = {0.6, 0.0, 0.8};
        double turned[3];
        ss_rotate(turned, by->q, along);
        give(s, "rho_direction", 0.05);
        give(s, "rho_across", 0.4);
        give_direction(s, turned[0], turned[1], turned[2]);
    }
    *node = renumber(by, is_volume ? 4 * 25 + 2 * 5 + 4 : 5 * 16 + 3, plain->node_count);
    ss_rotate(force, by->q, force);
    push(s, node, force[0], force[1], force[2]);
    free_mesh(plain);
}

static double compare_changed(int kind, bool is_free, bool is_renumbered)
{
    const change none = {.q = {1.0, 0.0, 0.0, 0.0}};
    const change by = {
        .q = {0.8, 0.36, -0.48, 0.0}, .shift = {3.0, -7.0, 11.0}, .is_renumbered = is_renumbered};
    setup a, b;
    int32_t node_a, node_b;
    setup_kind(&a, kind, is_free, &none, &node_a);
    setup_kind(&b, kind, is_free, &by, &node_b);
    create(&a);
    create(&b);
    steps(&a, 200, 0.05);
    steps(&b, 200, 0.05);
    double worst = 0.0;
    for (int32_t i = 0; i < a.mesh->node_count; ++i) {
        const int32_t to = renumber(&by, i, a.mesh->node_count);
        const double u[3] = {moved(&a, i, 0), moved(&a, i, 1), moved(&a, i, 2)};
        double turned[3];
        ss_rotate(turned, by.q, u);
        for (int k = 0; k < 3; ++k) {
            worst = fmax(worst, fabs(turned[k] - moved(&b, to, k)));
        }
    }
    worst /= largest_displacement(&a);
    setup_fini(&a);
    setup_fini(&b);
    return worst;
}

TEST(place_and_numbering_do_not_matter)
{
    for (int kind = 0; kind < BODY_KINDS; ++kind) {
        for (int k = 0; k < 4; ++k) {
            assert_near(compare_changed(kind, k / 2 == 1, k % 2 == 1), 0.0, BY_TYPE(2e-5, 1e-11));
        }
    }
}

TEST(forces_are_the_gradient_of_the_potential)
{
    for (int kind = 0; kind < 2 * BODY_KINDS; ++kind) {
        const change none = {.q = {1.0, 0.0, 0.0, 0.0}};
        setup s;
        int32_t node;
        const bool is_volume = kind % BODY_KINDS >= BODY_VOLUME, is_free = kind >= BODY_KINDS;
        setup_kind(&s, kind % BODY_KINDS, is_free, &none, &node);
        if (!is_free) {
            give(&s, "pretension_j", 3.0);
        }
        if (!is_free && is_volume) {
            give(&s, "enclosed_bulk_pa", 200.0);
        }
        create(&s);
        random_state = 40u + (uint64_t)kind;
        check_network_gradient(&s, 0.1);
        setup_fini(&s);
    }
}

TEST(a_free_volume_gains_the_momentum_it_is_given)
{
    const change none = {.q = {1.0, 0.0, 0.0, 0.0}};
    setup s;
    int32_t node;
    setup_kind(&s, BODY_VOLUME_DIRECTED, true, &none, &node);
    give(&s, "damping_n_s_per_m4", 0.0);
    create(&s);
    steps(&s, 400, 0.05);
    double momentum[3] = {0.0, 0.0, 0.0}, mass = 0.0;
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        mass += s.model->material.mass[i];
        for (int k = 0; k < 3; ++k) {
            momentum[k] += s.model->material.mass[i] * (double)s.model->v[4 * i + k];
        }
    }
    assert_near(mass, 1000.0, 1e-9);
    for (int k = 0; k < 3; ++k) {
        assert_near(momentum[k], s.load[0].force[k] * s.time, BY_TYPE(1e-3, 1e-9));
    }
    assert_near(energy_gain(&s), 0.0, 1e-3 * info_of(&s).work);
    setup_fini(&s);
}

/* Forces without loads on all nodes at the present displacements. */
static void forces_of(setup *s, double (*out)[3])
{
    double unused;
    (void)potential(s, 0, 0, &unused);
    const ss_model *m = s->model;
    const ss_real *b = m->is_held ? m->first->b : m->first->b_turned;
    for (int32_t i = 0; i < m->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i + k;
            out[i][k] = (double)m->force[at] - (double)m->load_force[at] -
                        (double)m->rest_stiffness[i] * (double)m->d[at] -
                        m->first->c1 * (double)m->first->r[at] + m->first->c2 * (double)b[at];
        }
    }
}

/* The stable step by power iteration on the forces themselves, over the computed bound. */
static double measured_over_bound(int kind)
{
    const change none = {.q = {1.0, 0.0, 0.0, 0.0}};
    setup s;
    int32_t node;
    setup_kind(&s, kind, false, &none, &node);
    give(&s, kind < BODY_VOLUME ? "damping_n_s_per_m" : "damping_n_s_per_m4", 0.0);
    give(&s, "pretension_j", 1.0);
    create(&s);
    steps(&s, 10, 0.05);
    const int32_t n = s.mesh->node_count;
    const size_t count = (size_t)n;
    ss_real *u = calloc(count * 4, sizeof *u);
    double(*x)[3] = calloc(count, sizeof *x), (*f)[3] = calloc(count, sizeof *f);
    double(*g)[3] = calloc(count, sizeof *g);
    memcpy(u, s.model->u, count * 4 * sizeof *u);
    random_state = 3;
    for (int32_t i = 0; i < n; ++i) {
        ss_set3(x[i], random_unit(), random_unit(), random_unit());
    }
    const double bound = info_of(&s).stable_step, h = BY_TYPE(1e-2, 1e-5);
    double rate = 0.0;
    for (int round = 0; round < 150; ++round) {
        double norm = 0.0;
        for (int side = 0; side < 2; ++side) {
            for (int32_t i = 0; i < n; ++i) {
                const double w = (s.fixed[i] & 7) == 7 ? 0.0 : side == 0 ? h : -h;
                place(&s, i, (double)u[4 * i] + w * x[i][0], (double)u[4 * i + 1] + w * x[i][1],
                      (double)u[4 * i + 2] + w * x[i][2]);
            }
            forces_of(&s, side == 0 ? f : g);
        }
        for (int32_t i = 0; i < n; ++i) {
            for (int k = 0; k < 3; ++k) {
                const double slope = (g[i][k] - f[i][k]) / (2.0 * h * s.model->material.mass[i]);
                x[i][k] = (s.fixed[i] & 7) == 7 ? 0.0 : slope;
                norm += x[i][k] * x[i][k];
            }
        }
        rate = sqrt(norm);
        for (int32_t i = 0; i < n; ++i) {
            ss_scale3(x[i], x[i], 1.0 / rate);
        }
    }
    free(u);
    free(x);
    free(f);
    free(g);
    setup_fini(&s);
    return ss_cnn_rk4_limit(0.0, 0.0, rate) / bound;
}

TEST(the_step_bound_holds_for_all_elements)
{
    for (int kind = 0; kind < BODY_KINDS; ++kind) {
        const double ratio = measured_over_bound(kind);
        print_message("stable step measured over computed, body %d: %.3f\n", kind, ratio);
        assert_true(ratio >= 0.999 && ratio <= 1.6);
    }
}

/* ---- a tool on a grid ---- */

/* A plate of 10 cm whose border is held, a sphere of 1 cm pressed 4 mm into its middle. */
static double press_plate(bool is_grid, double across)
{
    enum { SIDE = 17 };
    double x[SIDE];
    setup s;
    for (int k = 0; k < SIDE; ++k) {
        x[k] = 0.1 * ((double)k / (SIDE - 1) - 0.5);
    }
    setup_init(&s, "cnn-energy",
               is_grid ? make_tensor_grid(SIDE, SIDE, x, x) : make_plate(SIDE - 1, 0.1));
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        const double *p = s.mesh->position[i];
        s.fixed[i] = fmax(fabs(p[0]), fabs(p[1])) > 0.0499 ? 7 : 0;
    }
    give_skin(&s);
    give(&s, "pretension_j", 0.5);
    give(&s, "rho_direction", 1.0);
    give(&s, "rho_across", across);
    give_direction(&s, 1.0, 0.0, 0.0);
    add_sphere(&s, 0, 0.01);
    s.plan.contact_reach = 0.00625; /* the same on both */
    create(&s);
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    tool[0].is_present = true;
    for (int k = 0; k < 600; ++k) {
        const double depth = 0.004 * fmin(1.0, k / 100.0);
        const ss_tool_pose to = {.position = {0.0, 0.0, 0.01 - depth},
                                 .orientation = {1.0, 0.0, 0.0, 0.0}};
        tool[0].from = k == 0 ? to : tool[0].to;
        tool[0].to = to;
        s.class->step(s.model, s.time, 1e-3, tool);
        s.time += 1e-3;
    }
    const double force = s.model->tools.tool[0].force[2];
    const int32_t middle = SIDE / 2 * SIDE + SIDE / 2;
    const double along_x = moved(&s, middle + (is_grid ? 3 * SIDE : 3), 2);
    const double along_y = moved(&s, middle + (is_grid ? 3 : 3 * SIDE), 2);
    if (across > 1.0) { /* the dent is drawn out to where rho is larger */
        assert_true(along_y < 1.02 * along_x && along_x < 0.0);
    } else {
        assert_near(along_y / along_x, 1.0, 0.02);
    }
    assert_near(energy_gain(&s), 0.0, 2e-3 * info_of(&s).elastic);
    assert_int_equal(info_of(&s).fault_bits, 0);
    setup_fini(&s);
    return force;
}

TEST(a_tool_presses_a_grid_as_it_presses_triangles)
{
    for (int k = 0; k < 2; ++k) {
        const double across = k == 0 ? 1.0 : 4.0;
        const double grid = press_plate(true, across), triangles = press_plate(false, across);
        print_message("grid %.4f N, triangles %.4f N\n", grid, triangles);
        assert_true(grid > 0.05);
        assert_near(grid / triangles, 1.0, 0.1);
    }
}

/* ---- volumes ---- */

/* A regular tetrahedron whose base is held; node 0 is its top, up along z. */
static void setup_apex(setup *s, double length)
{
    const int32_t tetrahedron[1][4] = {{1, 2, 3, 0}};
    double position[4][3] = {{0.0, 0.0, sqrt(2.0 / 3.0) * length}};
    for (int k = 0; k < 3; ++k) {
        ss_set3(position[k + 1], length / sqrt(3.0) * cos(2.0 * SS_PI * k / 3.0),
                length / sqrt(3.0) * sin(2.0 * SS_PI * k / 3.0), 0.0);
    }
    setup_init(s, "cnn-energy", make_tetrahedra(4, (const double(*)[3])position, 1, tetrahedron));
    s->fixed[1] = s->fixed[2] = s->fixed[3] = 7;
    give(s, "domain", 1.0);
    give(s, "rho", 0.05);
    per_node(s, 1.0, 2.0, 0.3);
}

TEST(an_apex_stores_half_e_v_eps_squared)
{
    /* kap = 1/(3 L^2), eps = (H z + z^2/2)/L^2, Qhat = V = L^3/(24 sqrt 2), w = sqrt 2 L/24. */
    const double length = 0.5, modulus = 4000.0, height = sqrt(2.0 / 3.0) * length;
    const double volume = length * length * length / (24.0 * sqrt(2.0));
    for (int kind = 0; kind < 3; ++kind) { /* E, the same by E^, saturated */
        setup s;
        int32_t top = 0;
        setup_apex(&s, length);
        give(&s, kind == 1 ? "modulus_j" : "modulus_pa", modulus * (kind == 1 ? volume : 1.0));
        if (kind == 2) {
            give(&s, "saturation", 20.0);
        }
        push(&s, &top, 0.0, 0.0, 2.0);
        create(&s);
        steps(&s, 20000, 0.01);
        const double z = moved(&s, 0, 2), eps = (height * z + 0.5 * z * z) / (length * length);
        const double limit = 20.0 * 0.05 * 3.0 * sqrt(2.0) / 24.0 * length / volume / modulus;
        const double stretch = kind == 2 ? fmin(eps, limit) : eps;
        const double force =
            0.3 * z + modulus * volume * stretch * (height + z) / (length * length);
        assert_true(z > 0.01 && (kind != 2 || eps > 1.2 * limit));
        assert_near(force, 2.0, BY_TYPE(1e-5, 1e-10));
        assert_near(info_of(&s).elastic,
                    0.15 * z * z + modulus * volume * stretch * (eps - 0.5 * stretch),
                    BY_TYPE(1e-6, 1e-12));
        setup_fini(&s);
    }
}

/* A block of 10 cm, its lower face held, under a sphere of 2 cm above the middle of the upper one.
 */
static void setup_block(setup *s, int cells, double pretension)
{
    setup_init(s, "cnn-energy", make_block(cells, 0.1));
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        s->fixed[i] = s->mesh->position[i][2] < -0.0499 ? 7 : 0;
    }
    give(s, "domain", 1.0);
    give(s, "modulus_j", 5.0);
    give(s, "pretension_j", pretension);
    give(s, "density_kg_m3", 1000.0);
    give(s, "damping_n_s_per_m4", 3e5);
    give(s, "rest_stiffness_n_per_m4", 5e5);
    add_sphere(s, 0, 0.02);
    s->plan.contact_reach = 0.02;
}

/* Presses `depth` into the upper face in 0.1 s, holds until `until` s; returns the force up. */
static double press(setup *s, double depth, double until)
{
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    tool[0].is_present = true;
    tool[0].to = (ss_tool_pose){.position = {0.0, 0.0, 0.071}, .orientation = {1.0, 0.0, 0.0, 0.0}};
    while (s->time < until) {
        tool[0].from = tool[0].to;
        tool[0].to.position[2] = 0.07 - depth * fmin(1.0, s->time / 0.1);
        s->class->step(s->model, s->time, 1e-3, tool);
        s->time += 1e-3;
    }
    return s->model->tools.tool[0].force[2];
}

TEST(a_pressed_volume_moves_inside)
{
    setup s;
    setup_block(&s, 6, 0.5);
    create(&s);
    const ss_model *m = s.model;
    double sigma = (double)INFINITY;
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        if (s.fixed[i] == 0 && m->network->surface_area[i] > 0.0) {
            sigma = fmin(sigma, m->material.mass[i] / m->network->surface_area[i]);
        }
    }
    assert_near(m->smallest_sigma, sigma, 1e-12 * sigma);
    const double force = press(&s, 0.012, 1.0);
    assert_true(force > 0.1 && m->tools.tool[0].penalty > 0.0);
    for (int32_t k = 0; k < m->tool[0].count; ++k) { /* touched on the surface alone */
        assert_true(m->network->surface_area[m->tool[0].node[k]] > 0.0);
    }
    double last = 0.0;
    for (int k = 1; k <= 6; ++k) { /* deeper inside less, nowhere nothing */
        const double here = -moved(&s, (3 * 7 + 3) * 7 + k, 2);
        assert_true(here > last);
        last = here;
    }
    assert_true(fabs(m->tools.tool[0].force[0]) < 0.02 * force);
    const ss_model_info info = info_of(&s);
    assert_true(info.active_nodes == s.mesh->node_count && info.fault_bits == 0);
    assert_near(energy_gain(&s), 0.0, 2e-3 * info.elastic);
    setup_fini(&s);
}

TEST(a_refined_volume_behaves_the_same_per_volume)
{
    SKIP_WHERE_REPEATED();
    double force[2];
    for (int k = 0; k < 2; ++k) {
        setup s;
        setup_block(&s, k == 0 ? 6 : 9, 0.5);
        s.plan.contact_stiffness = 2e7;
        create(&s);
        force[k] = press(&s, 0.012, 0.6);
        setup_fini(&s);
    }
    assert_near(force[1] / force[0], 1.0, 0.2);
}

TEST(an_enclosed_volume_resists_on_its_surface)
{
    double lost[2];
    for (int k = 0; k < 2; ++k) {
        setup s;
        setup_block(&s, 5, 0.3);
        give(&s, "enclosed_bulk_pa", k == 0 ? 1e-6 : 3000.0);
        create(&s);
        (void)press(&s, 0.012, 0.6);
        assert_near(s.model->enclosed[0].volume, 1e-3, 1e-9);
        for (int32_t i = 0; i < s.mesh->node_count; ++i) {
            const ss_real *n = s.model->normal + 4 * (ptrdiff_t)i;
            const bool is_outside = s.model->network->surface_area[i] > 0.0;
            assert_true(is_outside || (n[0] == 0 && n[1] == 0 && n[2] == 0));
        }
        lost[k] = -s.model->kernels->dot(s.model->part, s.model->normal, s.model->u);
        setup_fini(&s);
    }
    assert_true(lost[0] > 0.0 && lost[1] < 0.6 * lost[0]);
}

TEST(a_volume_with_too_many_edges_for_a_tool_is_refused)
{
    setup s;
    setup_block(&s, 27, 0.0);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        s.fixed[i] = s.mesh->position[i][2] < 0.0499 ? 7 : 0;
    }
    expect_refusal(&s, SOFTSIM_ERROR_UNSUPPORTED, "use a coarser mesh");
}

TEST(only_the_domain_that_is_asked_for_is_simulated)
{
    setup s;
    setup_init(&s, "cnn-energy", make_block(3, 1.0));
    int32_t top = (2 * 4 + 2) * 4 + 3;
    for (int32_t i = 0; i < 64; ++i) {
        s.fixed[i] = s.mesh->position[i][2] < -0.49 ? 7 : 0;
    }
    give(&s, "modulus_j", 5.0);
    per_node(&s, 1.0, 2.0, 0.3);
    push(&s, &top, 0.1, 0.0, 0.5);
    create(&s);
    assert_int_equal(s.model->network->cell_count, 56);
    assert_int_equal(s.model->network->edges.count, 3 * 56 - 6);
    assert_null(s.model->material.rho_across);
    steps(&s, 100, 0.05);
    const int32_t inside = (4 + 1) * 4 * 1 + 4 * 4 + 2; /* (2, 1, 2) */
    assert_true(s.model->network->surface_area[inside] == 0.0);
    assert_true(moved(&s, inside, 2) == 0.0 && moved(&s, top, 2) > 0.01);
    setup_fini(&s);
}

int main(void)
{
    ss_thread_flush_denormals();
    return run_all_tests(NULL, NULL);
}
