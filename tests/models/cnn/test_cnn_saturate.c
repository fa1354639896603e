/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * cnn-energy at the output K of its cells: the complementarity problem and the projection against
 * exhaustive search, one convex potential of several saturated sources, one equilibrium, and the
 * closed forms where there are any.
 */
#include "common/test.h"

#include "common/model_fixture.h"
#include "rt/thread.h"

/* ---- the complementarity problem ---- */

/* x := A^-1 x by elimination with pivoting; false where A is singular. */
static bool solve_dense(int n, double a[8][8], double *x)
{
    for (int step = 0; step < n; ++step) {
        int row = step;
        for (int i = step; i < n; ++i) {
            row = fabs(a[i][step]) > fabs(a[row][step]) ? i : row;
        }
        if (!(fabs(a[row][step]) > 1e-12)) {
            return false;
        }
        for (int j = 0; j < n; ++j) {
            const double t = a[step][j];
            a[step][j] = a[row][j];
            a[row][j] = t;
        }
        const double t = x[step];
        x[step] = x[row];
        x[row] = t;
        for (int i = step + 1; i < n; ++i) {
            const double factor = a[i][step] / a[step][step];
            for (int j = step; j < n; ++j) {
                a[i][j] -= factor * a[step][j];
            }
            x[i] -= factor * x[step];
        }
    }
    for (int i = n - 1; i >= 0; --i) {
        for (int j = i + 1; j < n; ++j) {
            x[i] -= a[i][j] * x[j];
        }
        x[i] /= a[i][i];
    }
    return true;
}

/* Tries every set of positive z: slow, and nothing to get wrong. */
static bool search_lcp(int n, const double *matrix, const double *q, double *out_z)
{
    for (int set = 0; set < 1 << n; ++set) {
        int member[8], count = 0;
        double a[8][8], x[8];
        for (int i = 0; i < n; ++i) {
            if ((set & (1 << i)) != 0) {
                member[count++] = i;
            }
        }
        for (int i = 0; i < count; ++i) {
            x[i] = -q[member[i]];
            for (int j = 0; j < count; ++j) {
                a[i][j] = matrix[member[i] * n + member[j]];
            }
        }
        if (!solve_dense(count, a, x)) {
            continue;
        }
        bool is_good = true;
        memset(out_z, 0, (size_t)n * sizeof *out_z);
        for (int i = 0; i < count; ++i) {
            out_z[member[i]] = x[i];
            is_good = is_good && x[i] >= 0.0;
        }
        for (int i = 0; is_good && i < n; ++i) {
            double w = q[i];
            for (int j = 0; j < n; ++j) {
                w += matrix[i * n + j] * out_z[j];
            }
            is_good = w >= -1e-10;
        }
        if (is_good) {
            return true;
        }
    }
    return false;
}

TEST(the_complementarity_problem_is_solved_exactly)
{
    random_state = 11;
    for (int trial = 0; trial < 400; ++trial) {
        const int n = 1 + trial % 8, rank = trial % 3 == 0 ? (n + 1) / 2 : n;
        double factor[8][8], matrix[64] = {0.0}, q[8], z[8], known[8];
        for (int i = 0; i < n; ++i) {
            q[i] = random_unit();
            for (int k = 0; k < rank; ++k) {
                factor[i][k] = random_unit();
            }
        }
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                for (int k = 0; k < rank; ++k) {
                    matrix[i * n + j] += factor[i][k] * factor[j][k];
                }
            }
        }
        const bool is_solvable = search_lcp(n, matrix, q, known);
        if (rank == n) {
            assert_true(is_solvable);
        }
        assert_true(ss_cnn_lcp(n, matrix, q, z) == is_solvable);
        for (int i = 0; is_solvable && i < n; ++i) {
            double w = q[i], size = 1.0;
            for (int j = 0; j < n; ++j) {
                w += matrix[i * n + j] * z[j];
                size += fabs(matrix[i * n + j]) * z[j];
            }
            assert_true(z[i] >= 0.0);
            assert_true(w >= -1e-11 * size);
            assert_true(z[i] * w <= 1e-9 * size * (1.0 + z[i]));
            if (rank == n && trial % 3 != 0) {
                assert_near(z[i], known[i], 1e-6 * (1.0 + fabs(known[i])));
            }
        }
    }
}

enum { SIZE = 5 };

/* A problem of projection as bodies make it: potentials fall with the distance. */
static void draw_problem(double metric[SIZE], double potential[SIZE * SIZE], double wish[SIZE])
{
    double at[SIZE];
    for (int k = 0; k < SIZE; ++k) {
        at[k] = random_unit();
        metric[k] = exp(1.5 * random_unit());
        wish[k] = fmax(0.0, 3.0 * random_unit() + 1.5);
    }
    for (int k = 0; k < SIZE; ++k) {
        for (int l = 0; l < SIZE; ++l) { /* not symmetric: cells of different size */
            potential[k * SIZE + l] =
                exp(-2.0 * fabs(at[k] - at[l])) * (1.0 + 0.3 * random_unit()) * (k == l ? 1.5 : 1);
        }
    }
}

TEST(strengths_are_the_projection_and_nothing_is_nearer)
{
    random_state = 5;
    int held = 0, off = 0;
    for (int trial = 0; trial < 200; ++trial) {
        double metric[SIZE], potential[SIZE * SIZE], wish[SIZE], x[SIZE];
        int32_t bound;
        draw_problem(metric, potential, wish);
        wish[0] = fmax(wish[0], 0.1);
        assert_true(ss_cnn_project(SIZE, metric, potential, 1.0, wish, x, &bound));
        held += bound > 1;
        double highest = 0.0;
        for (int k = 0; k < SIZE; ++k) {
            double sum = 0.0;
            for (int l = 0; l < SIZE; ++l) {
                sum += potential[k * SIZE + l] * x[l];
            }
            assert_true(x[k] >= 0.0 && sum <= 1.0 + 1e-11);
            off += x[k] == 0.0 && wish[k] > 0.0;
            highest = fmax(highest, sum);
        }
        /* (y - x).(x - wish)/metric >= 0 for every allowed y: exactly the projection. */
        for (int other = 0; other < 50; ++other) {
            double y[SIZE], most = 0.0, product = 0.0;
            for (int k = 0; k < SIZE; ++k) {
                y[k] = fmax(0.0, random_unit());
            }
            for (int k = 0; k < SIZE; ++k) {
                double sum = 0.0;
                for (int l = 0; l < SIZE; ++l) {
                    sum += potential[k * SIZE + l] * y[l];
                }
                most = fmax(most, sum);
            }
            for (int k = 0; k < SIZE; ++k) {
                product += (y[k] / fmax(most, 1e-300) - x[k]) * (x[k] - wish[k]) / metric[k];
            }
            assert_true(most == 0.0 || product >= -1e-10);
        }
    }
    assert_true(held > 50 && off > 20); /* the interesting cases were there */
}

/* Wishes far beyond K: what acts is a small share of them. It never exceeds K, and as long as it is
 * said to be solved nothing is nearer. */
TEST(wishes_far_beyond_the_output_keep_every_condition)
{
    random_state = 3;
    for (int trial = 0; trial < 600; ++trial) {
        const double over = pow(10.0, trial % 300);
        double metric[SIZE], potential[SIZE * SIZE], wish[SIZE], x[SIZE], y[SIZE];
        double product = 0.0, most = 0.0;
        int32_t bound;
        draw_problem(metric, potential, wish);
        wish[0] = fmax(wish[0], 0.1);
        const bool is_solved = ss_cnn_project(SIZE, metric, potential, 1.0 / over, wish, x, &bound);
        assert_true(is_solved || over > 1e6);
        for (int k = 0; k < SIZE; ++k) {
            y[k] = fmax(0.0, random_unit());
        }
        for (int k = 0; k < SIZE; ++k) {
            double sum = 0.0, other = 0.0;
            for (int l = 0; l < SIZE; ++l) {
                sum += potential[k * SIZE + l] * (x[l] * over);
                other += potential[k * SIZE + l] * y[l];
            }
            assert_true(x[k] >= 0.0 && sum <= 1.0 + 1e-9);
            most = fmax(most, other);
        }
        /* (y - x).(x - wish)/metric >= 0 for every allowed y, in units of K. */
        for (int k = 0; k < SIZE && most > 0.0; ++k) {
            product += (y[k] / most - x[k] * over) * (x[k] - wish[k]) / metric[k];
        }
        assert_true(!is_solved || product >= -1e-8);
    }
}

/* Strengths of given currents with the literal clip: current leaves saturated cells only. */
static void clip(const double potential[SIZE * SIZE], const double *wish, double *out)
{
    double q[SIZE], z[SIZE], green[SIZE * SIZE];
    for (int k = 0; k < SIZE; ++k) {
        q[k] = 1.0;
        for (int l = 0; l < SIZE; ++l) {
            green[k * SIZE + l] = potential[k * SIZE + l];
            q[k] -= potential[k * SIZE + l] * wish[l];
        }
    }
    assert_true(ss_cnn_lcp(SIZE, green, q, z));
    for (int k = 0; k < SIZE; ++k) {
        out[k] = wish[k] - z[k];
    }
}

/* slope[k][l] = dX_k/deps_l of the projection, or of the clip; false across a kink. */
static bool find_slopes(const double *metric, const double *potential, double *wish, bool is_clip,
                        double slope[SIZE][SIZE])
{
    const double h = 1e-6;
    bool is_smooth = true;
    for (int l = 0; l < SIZE; ++l) {
        double x[3][SIZE];
        for (int s = 0; s < 3; ++s) {
            int32_t bound;
            const double before = wish[l];
            wish[l] += (s - 1) * h * metric[l];
            if (is_clip) {
                clip(potential, wish, x[s]);
            } else {
                assert_true(ss_cnn_project(SIZE, metric, potential, 1.0, wish, x[s], &bound));
            }
            wish[l] = before;
        }
        for (int k = 0; k < SIZE; ++k) {
            slope[k][l] = (x[2][k] - x[0][k]) / (2.0 * h);
            is_smooth = is_smooth && fabs(x[2][k] - 2.0 * x[1][k] + x[0][k]) < 1e-5 * h * metric[l];
        }
    }
    return is_smooth;
}

TEST(the_projection_is_a_gradient_and_the_literal_clip_is_none)
{
    random_state = 8;
    int smooth = 0;
    double clip_twist = 0.0;
    for (int trial = 0; trial < 100; ++trial) {
        double metric[SIZE], potential[SIZE * SIZE], wish[SIZE], slope[SIZE][SIZE], y[SIZE];
        draw_problem(metric, potential, wish);
        for (int k = 0; k < SIZE; ++k) { /* symmetric: the clip is a problem of its own then */
            wish[k] += 0.1;
            y[k] = random_unit();
            for (int l = 0; l < k; ++l) {
                potential[k * SIZE + l] = potential[l * SIZE + k];
            }
        }
        if (find_slopes(metric, potential, wish, true, slope)) {
            for (int k = 0; k < SIZE; ++k) {
                for (int l = 0; l < k; ++l) {
                    clip_twist = fmax(clip_twist, fabs(slope[k][l] - slope[l][k]));
                }
            }
        }
        if (!find_slopes(metric, potential, wish, false, slope)) {
            continue;
        }
        ++smooth;
        double curvature = 0.0, whole = 0.0;
        for (int k = 0; k < SIZE; ++k) {
            whole += metric[k] * y[k] * y[k];
            for (int l = 0; l < SIZE; ++l) {
                assert_near(slope[k][l], slope[l][k], 1e-6);
                curvature += y[k] * slope[k][l] * y[l];
            }
        }
        assert_true(curvature >= -1e-6 && curvature <= whole + 1e-6);
    }
    assert_true(smooth > 50);
    assert_true(clip_twist > 0.1);
}

/* ---- bodies ---- */

/* Three loads at the top of a body; the third's source has three cells. */
typedef struct trio {
    int32_t first, second, third[3];
} trio;

static void setup_trio(setup *s, trio *at, double rho, double saturation)
{
    setup_body(s, 4);
    double place[3][3] = {{0.5, 0.0, 0.7}, {0.2, 0.4, 0.75}, {-0.2, -0.3, 0.7}};
    int32_t nearest[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
        double best = (double)INFINITY;
        for (int32_t i = 0; i < s->mesh->node_count; ++i) {
            double away[3];
            ss_sub3(away, s->mesh->position[i], place[k]);
            nearest[k] = ss_norm3(away) < best ? i : nearest[k];
            best = fmin(best, ss_norm3(away));
        }
    }
    at->first = nearest[0];
    at->second = nearest[1];
    at->third[0] = nearest[2];
    int found = 1;
    for (int32_t t = 0; t < s->mesh->triangle_count && found < 3; ++t) {
        const int32_t *c = s->mesh->triangle[t];
        for (int k = 0; k < 3; ++k) {
            if (c[k] == nearest[2]) {
                at->third[1] = c[(k + 1) % 3];
                at->third[2] = c[(k + 2) % 3];
                found = 3;
            }
        }
    }
    give(s, "rho", rho);
    if (saturation > 0.0) {
        give(s, "saturation", saturation);
    }
    push(s, &at->first, 0.2, 0.1, 0.9);
    push(s, &at->second, 0.0, 0.0, 0.7);
    push(s, at->third, -0.3, 0.0, 0.8);
    s->load[2].node_count = 3;
}

TEST(strengths_in_a_body_keep_every_condition)
{
    setup s;
    trio at;
    const double limit = 0.3;
    setup_trio(&s, &at, 0.05, limit);
    create(&s);
    assert_non_null(s.model->saturation);
    int shared = 0;
    for (int k = 0; k < 60; ++k) {
        steps(&s, 10, 0.05);
        double x[3], pressed[3] = {0.0}, highest = 0.0;
        for (int m = 0; m < 3; ++m) {
            const ss_cnn_source *source = &s.model->source[m];
            x[m] = source->modulus * source->stretch;
            assert_true(x[m] >= 0.0 && source->stretch <= fmax(source->eps, 0.0) * (1 + 1e-9));
            assert_near(source->c1, x[m], 1e-12 * (1.0 + x[m]));
        }
        for (int m = 0; m < 3; ++m) {
            for (int l = 0; l < 3; ++l) {
                pressed[m] += s.model->saturation->potential[m][l] * x[l];
            }
            assert_true(pressed[m] <= limit * (1.0 + 1e-10));
            highest = fmax(highest, pressed[m]);
        }
        for (int m = 0; m < 3; ++m) { /* less than it wished: somebody is at K */
            const ss_cnn_source *source = &s.model->source[m];
            if (source->stretch < source->eps * (1.0 - 1e-9)) {
                assert_near(highest, limit, 1e-9 * limit);
                shared += x[m] < 0.99 * limit / s.model->saturation->potential[m][m];
            }
        }
    }
    assert_true(shared > 20); /* it is more than each one's own limit */
    setup_fini(&s);
}

TEST(potentials_are_those_of_the_network)
{
    setup s;
    trio at;
    setup_trio(&s, &at, 0.05, 0.3);
    create(&s);
    const ss_cnn_network *network = s.model->network;
    double *field = calloc((size_t)s.mesh->node_count, sizeof *field);
    const double one = 1.0;
    ss_cnn_network_potential(network, 1, &at.first, &one, field);
    assert_near(field[at.first], network->own[at.first], 1e-12);
    /* The column satisfies the equation that defines it. */
    double *flow = calloc((size_t)s.mesh->node_count, sizeof *flow);
    for (int32_t e = 0; e < network->edges.count; ++e) {
        const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
        flow[i] += network->edge_weight[e] * (field[i] - field[j]);
        flow[j] += network->edge_weight[e] * (field[j] - field[i]);
    }
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        const double source = i == at.first ? network->size[i] / 0.05 : 0.0;
        assert_near(s.fixed[i] == 7 ? field[i] : flow[i] - source, 0.0, 1e-11);
    }
    const double qhat = network->qhat[at.first];
    assert_near(s.model->saturation->potential[1][0], field[at.second] / qhat, 1e-12);
    assert_near(s.model->saturation->potential[2][0],
                (field[at.third[0]] + field[at.third[1]] + field[at.third[2]]) / (3.0 * qhat),
                1e-12);
    assert_near(s.model->saturation->potential[0][0], field[at.first] / qhat, 1e-12);
    free(field);
    free(flow);
    setup_fini(&s);
}

TEST(forces_of_saturated_sources_are_one_gradient)
{
    setup s;
    trio at;
    setup_trio(&s, &at, 0.05, 0.3);
    create(&s);
    steps(&s, 100, 0.05);
    double force;
    potential(&s, at.first, 2, &force);
    int32_t limited = 0;
    for (int m = 0; m < 3; ++m) {
        limited += s.model->source[m].stretch < 0.98 * s.model->source[m].eps;
    }
    assert_true(limited >= 2);
    const double h = BY_TYPE(3e-3, 1e-6);
    const int32_t node[4] = {at.first, at.second, at.third[0], at.third[1]};
    for (int n = 0; n < 4; ++n) {
        for (int k = 0; k < 3; ++k) {
            const ptrdiff_t index = 4 * (ptrdiff_t)node[n] + k;
            const ss_real before = s.model->u[index];
            double high, low;
            potential(&s, node[n], k, &force);
            const double wanted = force;
            s.model->u[index] = (ss_real)((double)before + h);
            const double up = (double)s.model->u[index];
            high = potential(&s, node[n], k, &force);
            s.model->u[index] = (ss_real)((double)before - h);
            const double down = (double)s.model->u[index];
            low = potential(&s, node[n], k, &force);
            s.model->u[index] = before;
            assert_near(-(high - low) / (up - down), wanted, BY_TYPE(3e-3, 1e-6));
        }
    }
    setup_fini(&s);
}

TEST(saturated_bodies_have_one_equilibrium)
{
    setup a, b;
    trio at, other;
    setup_trio(&a, &at, 0.05, 0.3);
    setup_trio(&b, &other, 0.05, 0.3);
    create(&a);
    create(&b);
    random_state = 21;
    crumple(&b, 0.5);
    steps(&a, 4000, 0.05);
    steps(&b, 4000, 0.05);
    double largest = 0.0;
    for (int32_t i = 0; i < a.mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            largest = fmax(largest, fabs(moved(&a, i, k) - moved(&b, i, k)));
        }
    }
    assert_true(largest_displacement(&a) > 0.3);
    assert_true(largest < BY_TYPE(2e-4, 1e-5) * largest_displacement(&a));
    setup_fini(&a);
    setup_fini(&b);
}

TEST(doubling_rho_doubles_the_saturation_of_several_too)
{
    setup a, b, c;
    trio at[3];
    setup_trio(&a, &at[0], 0.05, 0.3);
    setup_trio(&b, &at[1], 0.1, 0.15);
    setup_trio(&c, &at[2], 0.05, 0.0);
    create(&a);
    create(&b);
    create(&c);
    assert_null(c.model->saturation); /* nothing is kept without K */
    steps(&a, 400, 0.05);
    steps(&b, 400, 0.05);
    steps(&c, 400, 0.05);
    double same = 0.0, different = 0.0;
    for (int32_t i = 0; i < a.mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            same = fmax(same, fabs(moved(&a, i, k) - moved(&b, i, k)));
            different = fmax(different, fabs(moved(&a, i, k) - moved(&c, i, k)));
        }
    }
    assert_true(same < BY_TYPE(1e-5, 1e-11));
    assert_true(different > 0.05);
    assert_near(energy_gain(&a) / info_of(&a).work, 0.0, 1e-4);
    setup_fini(&a);
    setup_fini(&b);
    setup_fini(&c);
}

TEST(two_fans_that_do_not_touch_saturate_each_on_its_own)
{
    draft d;
    setup s;
    int32_t centre[2] = {0, 7};
    draft_init(&d, 14, 12);
    for (int fan = 0; fan < 2; ++fan) {
        draft_node(&d, 2.0 * fan, 0.0, 0.0);
        for (int k = 0; k < 6; ++k) {
            draft_node(&d, 2.0 * fan + FAN_EDGE * cos(k * SS_PI / 3.0),
                       FAN_EDGE * sin(k * SS_PI / 3.0), 0.0);
        }
        for (int k = 0; k < 6; ++k) {
            draft_triangle(&d, 7 * fan, 7 * fan + 1 + k, 7 * fan + 1 + (k + 1) % 6);
        }
    }
    setup_init(&s, "cnn-energy", draft_finish(&d));
    for (int k = 0; k < 14; ++k) {
        s.fixed[k] = k % 7 == 0 ? 0 : 7;
    }
    give(&s, "modulus_n_per_m", 60.0);
    give(&s, "rho", 0.05);
    give(&s, "saturation", 0.2);
    per_node(&s, 1.0, 2.0, 0.3);
    push(&s, &centre[0], 0.0, 0.0, 0.5);
    push(&s, &centre[1], 0.0, 0.8, 0.0);
    create(&s);
    assert_non_null(s.model->saturation);
    steps(&s, 20000, 0.02);
    const double stiffness = 0.3 + 6.0 * 0.05 * 0.2 / (FAN_EDGE * FAN_EDGE);
    assert_near(moved(&s, 0, 2), 0.5 / stiffness, BY_TYPE(1e-6, 1e-11));
    assert_near(moved(&s, 7, 1), 0.8 / stiffness, BY_TYPE(1e-6, 1e-11));
    setup_fini(&s);
}

TEST(too_many_saturated_sources_are_refused)
{
    static int32_t node[17];
    static ss_load load[17];
    setup s;
    setup_body(&s, 4);
    int count = 0;
    for (int32_t i = 0; i < s.mesh->node_count && count < 17; ++i) {
        if (s.fixed[i] == 0) {
            node[count] = i;
            load[count] = (ss_load){.node = &node[count],
                                    .node_count = 1,
                                    .force = {0.0, 0.0, 0.1},
                                    .to = (double)INFINITY};
            ++count;
        }
    }
    s.plan.load = load;
    s.plan.load_count = 17;
    give(&s, "saturation", 0.3);
    expect_refusal(&s, SOFTSIM_ERROR_SCENE, "at most 16");
    setup_body(&s, 4);
    s.plan.load = load;
    s.plan.load_count = 16;
    give(&s, "saturation", 0.3);
    create(&s);
    steps(&s, 50, 0.05);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
    setup_fini(&s);
}

/* ---- for given currents ---- */

TEST(the_obstacle_is_met_exactly_where_currents_are_cut)
{
    setup s;
    setup_cylinder(&s, 1.0);
    create(&s);
    ss_cnn_network *network = s.model->network;
    const int32_t n = s.mesh->node_count;
    const int32_t cell[3] = {TOP, TOP + 2, TOP + 24 * 3};
    const double limit = 1.0;
    double *y = calloc((size_t)n, sizeof *y), *sweep = calloc((size_t)n, sizeof *sweep);
    double *centre = calloc((size_t)n, sizeof *centre);
    for (int trial = 0; trial < 3; ++trial) {
        const double current[3] = {trial == 0 ? 0.2 : 20.0, trial == 2 ? 0.1 : 12.0, 1.5};
        assert_int_equal(ss_cnn_obstacle(network, 3, cell, current, limit, y), SOFTSIM_OK);
        /* Projected Gauss-Seidel on (1) and (2) at rest: slow and plain. */
        memset(sweep, 0, (size_t)n * sizeof *sweep);
        memset(centre, 0, (size_t)n * sizeof *centre);
        for (int32_t e = 0; e < network->edges.count; ++e) {
            centre[network->edges.from[e] / 4] += network->edge_weight[e];
            centre[network->edges.to[e] / 4] += network->edge_weight[e];
        }
        for (int round = 0; round < 900; ++round) {
            for (int32_t row = 0; row < network->rows.row_count; ++row) {
                const int32_t i = network->rows.node[row] / 4;
                double sum = 0.0;
                for (int k = 0; k < 3; ++k) {
                    sum += cell[k] == i ? current[k] * network->size[i] / 0.05 : 0.0;
                }
                for (int32_t g = 0; g < network->rows.group_count; ++g) {
                    const ss_cnn_group *group = &network->rows.group[g];
                    const int32_t in = row - group->first_row;
                    for (int32_t k = 0; in >= 0 && in < group->row_count && k < group->degree;
                         ++k) {
                        const int32_t at = group->first_entry + in * group->degree + k;
                        sum += network->edge_weight[network->rows.edge[at]] *
                               sweep[network->rows.neighbour[at] / 4];
                    }
                }
                sweep[i] = fmin(limit, sum / centre[i]);
            }
        }
        for (int32_t i = 0; i < n; ++i) {
            assert_near(y[i], sweep[i], 1e-7);
        }
        assert_true(trial == 0 ? y[cell[0]] < limit : fabs(y[cell[0]] - limit) < 1e-12);
    }
    assert_int_equal(ss_cnn_obstacle(network, 0, cell, y, limit, y), SOFTSIM_ERROR_ARGUMENT);
    free(y);
    free(sweep);
    free(centre);
    setup_fini(&s);
}

int main(void)
{
    ss_thread_flush_denormals();
    return run_all_tests(NULL, NULL);
}
