/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/hybrid/hybrid.h"
/*
 * Activation of particles near a tool, with mass and momentum conserved.
 *
 * Where. The layer's search grid lies over rest positions, so the tool is pulled back to rest: by
 * the mean displacement of the skin around it. A particle is wanted when it is nearer to the
 * pulled-back tool's surface than wake_reach, and released beyond sleep_reach; where that would be
 * more than max_awake, both reaches shrink in proportion (a histogram of distances finds the
 * largest that fits), so that the nearest wake and the awake region keeps up with the tool. Only a
 * tool that has moved by a quarter of a spacing since is looked at again.
 *
 * How. Every fourth outer step, since a change costs an evaluation of all forces, as much as a
 * sub-step. Wanted: it and its neighbours become points, whose blends rise by BLEND_STEP each time.
 * Half way up a wanted particle gets a node: u = T u, and mass and momentum of it from the four
 * nodes of its host. Released: the node is given back when the particle is within a tenth of a
 * spacing of its tie, or MAX_RELEASE_UPDATES updates later at the latest, and its blend falls from
 * then on; what is left of the way is kept as an offset that decays to nothing. Places do not jump
 * nor, since stiffness and skin rows only fade, do forces.
 *
 * Mass and momentum. Waking takes m/4 and its momentum from each node of the host, falling asleep
 * gives both back: exact, but for axes that are held, whose support takes the difference. Kinetic
 * energy is lost both ways, since one velocity is the mean of several. Stored energy is not kept
 * either: the layer bends where its host cannot. The forces and energies are therefore evaluated
 * again after a change, and the body books the difference as work, so that its energy balance still
 * tells true gains. Rejected: freezing the particle where it is (springs of the frozen lattice
 * would hold the dent); giving the new node the interpolated velocity T v and taking the difference
 * from its host. Each waking then gains kinetic energy: a tool passing over an undamped body
 * without touching it tripled the body's energy in 20 s.
 */
#include <math.h>
#include <string.h>

#include "rt/vec.h"

#define BLEND_STEP 0.5  /* of a blend, a change */
#define DRIFT      0.41 /* of an offset is left after a change */
#define NEAR_TIE   0.1  /* spacings */
#define LOOK_MOVE  0.25 /* spacings */
#define SCAN_RATIO 1.1  /* of the reach of the last look: how far the next one looks */
/* Outer steps from change to change: forces are evaluated again after each. Half as much every
 * other step was as smooth, and needed twice as many evaluations: in a slide over HM1's wall the
 * force jumps by 0.9 % at most from step to step, and by 1 % over half a spacing, with both. */
enum { UPDATE_INTERVAL = 4 };
enum { BINS = 64, MAX_RELEASE_UPDATES = 16 };

/* ---- mass and momentum ---- */

static double particle_mass(const ss_hybrid *hybrid, int32_t p)
{
    return hybrid->layer->volume[p] * hybrid->material.density[hybrid->layer->host[p]];
}

/* Gives `mass` (m/4) of velocity v back to node i. */
static void give_mass(ss_hybrid *hybrid, int32_t i, double mass, const double v[3])
{
    ss_body_nodes *nodes = ss_body_get_nodes(hybrid->body);
    const double before = nodes->mass[i];
    const double after = before + mass;
    for (int a = 0; a < 3; ++a) {
        ss_real *at = &nodes->v[4 * (ptrdiff_t)i + a];
        const double old = (double)*at;
        if (nodes->mobility[4 * (ptrdiff_t)i + a] > 0) {
            *at = (ss_real)((before * old + mass * v[a]) / after);
        }
    }
    ss_body_set_mass(hybrid->body, i, after);
}

static void wake_particle(ss_hybrid *hybrid, int32_t p)
{
    ss_body_nodes *nodes = ss_body_get_nodes(hybrid->body);
    const int32_t node = hybrid->idle[--hybrid->idle_count];
    const int32_t *host = hybrid->mesh->tetrahedron[hybrid->layer->host[p]];
    const double mass = particle_mass(hybrid, p);
    double u[3];
    double v[3] = {0.0, 0.0, 0.0};
    ss_hybrid_tied(hybrid, p, nodes->u, u);
    for (int k = 0; k < 4; ++k) {
        for (int a = 0; a < 3; ++a) {
            v[a] += 0.25 * (double)nodes->v[4 * (ptrdiff_t)host[k] + a];
        }
        ss_body_set_mass(hybrid->body, host[k], nodes->mass[host[k]] - 0.25 * mass);
    }
    ss_body_set_mass(hybrid->body, node, mass);
    for (int a = 0; a < 3; ++a) {
        nodes->u[4 * (ptrdiff_t)node + a] =
            (ss_real)(u[a] + (double)hybrid->offset[4 * (ptrdiff_t)p + a]);
        nodes->v[4 * (ptrdiff_t)node + a] = (ss_real)v[a];
        hybrid->offset[4 * (ptrdiff_t)p + a] = 0;
    }
    hybrid->node_of[p] = node;
    ss_hybrid_move_near(hybrid, p);
    ++hybrid->awake_count;
    ss_hybrid_tell_skin(hybrid, p, 0);
}

static void tie_particle(ss_hybrid *hybrid, int32_t p)
{
    ss_body_nodes *nodes = ss_body_get_nodes(hybrid->body);
    const int32_t node = hybrid->node_of[p];
    const int32_t *host = hybrid->mesh->tetrahedron[hybrid->layer->host[p]];
    const double mass = particle_mass(hybrid, p);
    double u[3], v[3];
    for (int a = 0; a < 3; ++a) {
        v[a] = (double)nodes->v[4 * (ptrdiff_t)node + a];
    }
    for (int k = 0; k < 4; ++k) {
        give_mass(hybrid, host[k], 0.25 * mass, v);
    }
    ss_hybrid_tied(hybrid, p, nodes->u, u);
    for (int a = 0; a < 3; ++a) {
        const ptrdiff_t at = 4 * (ptrdiff_t)node + a;
        hybrid->offset[4 * (ptrdiff_t)p + a] = (ss_real)((double)nodes->u[at] - u[a]);
        nodes->u[at] = 0;
        nodes->v[at] = 0;
    }
    ss_body_set_mass(hybrid->body, node, 0.0);
    hybrid->drifting[hybrid->drifting_count++] = p;
    hybrid->idle[hybrid->idle_count++] = node;
    hybrid->node_of[p] = -1;
    ss_hybrid_move_near(hybrid, p);
    --hybrid->awake_count;
    ss_hybrid_tell_skin(hybrid, p, 0);
}

/* How far an awake particle is from its tie, m. */
static double tie_distance(const ss_hybrid *hybrid, int32_t p)
{
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    double u[3];
    ss_hybrid_tied(hybrid, p, nodes->u, u);
    for (int a = 0; a < 3; ++a) {
        u[a] -= (double)nodes->u[4 * (ptrdiff_t)hybrid->node_of[p] + a];
    }
    return ss_norm3(u);
}

static void decay_offsets(ss_hybrid *hybrid)
{
    for (int32_t k = hybrid->drifting_count - 1; k >= 0; --k) {
        const int32_t p = hybrid->drifting[k];
        ss_real *offset = hybrid->offset + 4 * (ptrdiff_t)p;
        const ss_real least = (ss_real)(1e-4 * hybrid->layer->spacing[p]);
        bool is_there = hybrid->node_of[p] < 0;
        for (int a = 0; a < 3; ++a) {
            offset[a] *= (ss_real)DRIFT;
            is_there = is_there && (double)offset[a] < (double)least && -offset[a] < least;
        }
        if (is_there || hybrid->node_of[p] >= 0) {
            memset(offset, 0, 3 * sizeof *offset);
            hybrid->drifting[k] = hybrid->drifting[--hybrid->drifting_count];
        }
        ss_hybrid_move_near(hybrid, p);
    }
}

/* ---- wanted ---- */

static bool is_up(const ss_hybrid *hybrid, int32_t p)
{
    return hybrid->particle[p].wanted >= 0 || hybrid->node_of[p] >= 0;
}

/* What p's blend goes to: all of it while it is wanted or awake, else by its nearest neighbour that
 * is. */
static void set_target(ss_hybrid *hybrid, int32_t p)
{
    const ss_layer *layer = hybrid->layer;
    double target = is_up(hybrid, p) ? 1.0 : 0.0;
    for (int32_t t = layer->pair_first[p]; t < layer->pair_first[p + 1] && target == 0.0; ++t) {
        if (is_up(hybrid, layer->neighbour[t])) { /* nearest first */
            target = ss_hybrid_blend_beside((double)layer->pair[4 * (ptrdiff_t)t + 3]);
            break;
        }
    }
    hybrid->particle[p].target = (ss_real)target;
    hybrid->is_fading = true;
}

/* The same for p and its neighbours, as far as they are points. */
static void set_targets_around(ss_hybrid *hybrid, int32_t p)
{
    const ss_layer *layer = hybrid->layer;
    set_target(hybrid, p);
    for (int32_t t = layer->pair_first[p]; t < layer->pair_first[p + 1]; ++t) {
        if (hybrid->particle[layer->neighbour[t]].point >= 0) {
            set_target(hybrid, layer->neighbour[t]);
        }
    }
}

/* Those who become points where there is room for them. */
static void mark_wanted(ss_hybrid *hybrid, int32_t p)
{
    const ss_layer *layer = hybrid->layer;
    ss_hybrid_particle *particle = &hybrid->particle[p];
    const int32_t pairs = layer->pair_first[p + 1] - layer->pair_first[p];
    /* No particle is a point twice: as many places as particles are always enough. */
    const bool has_room =
        hybrid->max_points == layer->count || hybrid->point_count + pairs + 1 <= hybrid->max_points;
    if (hybrid->is_held[p] || hybrid->wanted_count == hybrid->max_awake || !has_room) {
        return;
    }
    particle->wanted = hybrid->wanted_count;
    hybrid->wanted[hybrid->wanted_count++] = p;
    for (int32_t t = layer->pair_first[p] - 1; t < layer->pair_first[p + 1]; ++t) {
        const int32_t q = t < layer->pair_first[p] ? p : layer->neighbour[t];
        if (!(layer->moment[8 * (ptrdiff_t)q + 6] > 0)) {
            continue; /* a ghost at the end of the lattice: no gradient of its own */
        }
        set_target(hybrid, q);
        if (hybrid->particle[q].point < 0 && hybrid->particle[q].target > 0) {
            ss_hybrid_add_point(hybrid, q);
        }
    }
    ss_hybrid_tell_skin(hybrid, p, 1);
}

static void unmark_wanted(ss_hybrid *hybrid, int32_t p)
{
    ss_hybrid_particle *particle = &hybrid->particle[p];
    const int32_t last = hybrid->wanted[--hybrid->wanted_count];
    hybrid->wanted[particle->wanted] = last;
    hybrid->particle[last].wanted = particle->wanted;
    particle->wanted = -1;
    particle->release_updates = MAX_RELEASE_UPDATES;
    set_targets_around(hybrid, p);
    ss_hybrid_tell_skin(hybrid, p, -1);
}

/* ---- blends ---- */

/* Moves p's blend by at most `step`; true when it was not there yet. */
static bool move_blend(ss_hybrid *hybrid, int32_t p, double step)
{
    const ss_hybrid_particle *particle = &hybrid->particle[p];
    const double from = (double)particle->blend;
    const double to = fmin(fmax((double)particle->target, from - step), from + step);
    if (to != from) {
        ss_hybrid_set_blend(hybrid, p, to);
    }
    return to != from;
}

/* Wakes half way to its blend, is tied when it is released and near its tie; true when it did. */
static bool move_node(ss_hybrid *hybrid, int32_t p)
{
    ss_hybrid_particle *particle = &hybrid->particle[p];
    const bool was_up = hybrid->node_of[p] >= 0;
    if (particle->wanted >= 0) {
        if (hybrid->node_of[p] < 0 && particle->blend >= (ss_real)0.5 && hybrid->idle_count > 0) {
            wake_particle(hybrid, p);
        }
    } else if (hybrid->node_of[p] >= 0 &&
               (--particle->release_updates <= 0 ||
                tie_distance(hybrid, p) < NEAR_TIE * hybrid->layer->spacing[p])) {
        tie_particle(hybrid, p);
        set_targets_around(hybrid, p);
    }
    return was_up != (hybrid->node_of[p] >= 0);
}

/* Everything one step further: blends, nodes, points that are used no more. False when all of them
 * are waiting for their tie: forces are as they were. */
static bool fade(ss_hybrid *hybrid, double step)
{
    bool has_changed = false;
    hybrid->is_fading = false;
    for (int32_t k = hybrid->point_count - 1; k >= 0; --k) {
        const int32_t p = hybrid->point[k];
        const ss_hybrid_particle *particle = &hybrid->particle[p];
        const bool has_moved = move_blend(hybrid, p, step);
        has_changed = move_node(hybrid, p) || has_moved || has_changed;
        const bool is_moving = particle->blend != particle->target ||
                               (particle->wanted >= 0) != (hybrid->node_of[p] >= 0);
        hybrid->is_fading = hybrid->is_fading || is_moving;
        if (!is_moving && !(particle->blend > 0)) {
            ss_hybrid_remove_point(hybrid, p);
        }
    }
    return has_changed;
}

/* ---- tools in the coordinates of rest ---- */

/* Displacement of the skin under the tool: the mean over the nodes in reach, the nearest counting
 * most, so that it moves smoothly. False where none is in reach. */
static bool find_shift(const ss_hybrid *hybrid, int probe, double out[3])
{
    const ss_layer *layer = hybrid->layer;
    const double *x = hybrid->tool[probe].to.position;
    const double reach = hybrid->around_reach[probe] - 0.5 * hybrid->skin_edge;
    const ss_real *shown = hybrid->laid;
    double total = 0.0;
    ss_set3(out, 0.0, 0.0, 0.0);
    for (int32_t k = 0; k < hybrid->around_count; ++k) {
        const int32_t i = layer->skin_node[hybrid->around[k]];
        const double u[3] = {(double)shown[4 * (ptrdiff_t)i], (double)shown[4 * (ptrdiff_t)i + 1],
                             (double)shown[4 * (ptrdiff_t)i + 2]};
        const double d[3] = {hybrid->mesh->position[i][0] + u[0] - x[0],
                             hybrid->mesh->position[i][1] + u[1] - x[1],
                             hybrid->mesh->position[i][2] + u[2] - x[2]};
        const double inside = 1.0 - ss_dot3(d, d) / (reach * reach);
        if (inside > 0.0) {
            const double weight = inside * inside * inside * inside;
            total += weight;
            ss_madd3(out, out, weight, u);
        }
    }
    ss_scale3(out, out, total > 0.0 ? 1.0 / total : 0.0);
    return total > 0.0;
}

/* Distances of the own particles within `most` of the pulled-back tool's surface; collects them in
 * `found`. */
static void scan(ss_hybrid *hybrid, int probe, const double middle[3], double most)
{
    const ss_layer *layer = hybrid->layer;
    const ss_point_grid *grid = &hybrid->grid;
    const ss_shape *shape = &hybrid->shape[probe].shape;
    const double *q = hybrid->tool[probe].to.orientation;
    const double reach = ss_shape_bounding_radius(shape) + most;
    int32_t low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        const double from = (middle[k] - reach - grid->low[k]) / grid->cell;
        const double to = (middle[k] + reach - grid->low[k]) / grid->cell;
        low[k] = (int32_t)fmin(fmax(floor(from), 0.0), grid->cells[k]);
        high[k] = (int32_t)fmax(fmin(floor(to), grid->cells[k] - 1.0), -1.0);
    }
    for (int32_t k = low[2]; k <= high[2]; ++k) {
        for (int32_t j = low[1]; j <= high[1]; ++j) {
            const int32_t row = (k * grid->cells[1] + j) * grid->cells[0];
            const int32_t end = high[0] < low[0] ? 0 : grid->first[row + high[0] + 1];
            for (int32_t m = high[0] < low[0] ? 0 : grid->first[row + low[0]]; m < end; ++m) {
                const int32_t p = grid->member[m];
                double x[3], local[3], normal[3];
                ss_sub3(x, layer->rest[p], middle);
                if (ss_dot3(x, x) > reach * reach) {
                    continue;
                }
                ss_rotate_back(local, q, x);
                const double d = ss_shape_distance(shape, local, normal);
                if (d < most && hybrid->distance[p] == (double)INFINITY) {
                    hybrid->found[hybrid->found_count++] = p;
                }
                if (d < hybrid->distance[p] && d < most) {
                    hybrid->distance[p] = d;
                }
            }
        }
    }
}

double ss_hybrid_most_wanted(const ss_hybrid *hybrid)
{
    return (hybrid->max_awake < hybrid->layer->own_count ? SS_HYBRID_FULL : 1.0) *
           hybrid->max_awake;
}

/* The reach within which particles wake: wake_reach, or less, so that no more are than may be. */
static double fit_reach(const ss_hybrid *hybrid)
{
    const double most = ss_hybrid_most_wanted(hybrid);
    int32_t bin[BINS] = {0};
    double low = hybrid->wake_reach;
    for (int32_t k = 0; k < hybrid->found_count; ++k) {
        low = fmin(low, hybrid->distance[hybrid->found[k]]);
    }
    const double width = (hybrid->wake_reach - low) / BINS;
    int32_t inside = 0;
    for (int32_t k = 0; k < hybrid->found_count; ++k) {
        const double d = hybrid->distance[hybrid->found[k]];
        if (d < hybrid->wake_reach) {
            const int32_t b = (int32_t)((d - low) / width);
            ++bin[b < BINS ? b : BINS - 1];
            ++inside;
        }
    }
    int b = BINS;
    while (b > 1 && inside > most) {
        inside -= bin[--b];
    }
    return low + b * width;
}

/* Does any tool ask for a new look? Fills where they are at rest. */
static bool is_look_due(ss_hybrid *hybrid, double middle[SOFTSIM_MAX_PROBES][3], bool *is_near)
{
    bool is_due = false;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        double shift[3] = {0.0, 0.0, 0.0};
        is_near[k] = hybrid->tool[k].is_present && find_shift(hybrid, k, shift);
        if (is_near[k]) {
            double moved[3];
            ss_sub3(middle[k], hybrid->tool[k].to.position, shift);
            ss_sub3(moved, middle[k], hybrid->scanned[k]);
            is_due = is_due || !hybrid->was_scanned[k] ||
                     ss_norm3(moved) > LOOK_MOVE * hybrid->least_spacing;
        }
        is_due = is_due || is_near[k] != hybrid->was_scanned[k];
    }
    return is_due;
}

static void forget_found(ss_hybrid *hybrid)
{
    for (int32_t k = 0; k < hybrid->found_count; ++k) {
        hybrid->distance[hybrid->found[k]] = (double)INFINITY;
    }
    hybrid->found_count = 0;
}

/* Finds the particles that wake (nearer than the reach that is returned) and those that may stay
 * awake (nearer than current_sleep_reach). Where max_active bounds both, a scan a little beyond the
 * last look's says the same as one to sleep_reach, which holds tens of times as many: counts below
 * a reach do not depend on what is further. When two tools reach the same particle, the first one
 * scanned lists it, so the order of waking may differ. */
static double find_near(ss_hybrid *hybrid, double middle[SOFTSIM_MAX_PROBES][3],
                        const bool *is_near)
{
    double most =
        fmin(SCAN_RATIO * hybrid->current_sleep_reach + hybrid->least_spacing, hybrid->sleep_reach);
    for (;;) {
        for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
            if (is_near[k]) {
                scan(hybrid, k, middle[k], most);
            }
        }
        const double reach = fit_reach(hybrid);
        const double band = (hybrid->sleep_reach / hybrid->wake_reach - 1.0) * fmax(reach, 0.0);
        hybrid->current_sleep_reach = reach + fmax(band, 0.5 * hybrid->least_spacing);
        if (most == hybrid->sleep_reach || hybrid->current_sleep_reach <= most) {
            return reach;
        }
        forget_found(hybrid);
        most = hybrid->sleep_reach;
    }
}

static void update_wanted(ss_hybrid *hybrid)
{
    double middle[SOFTSIM_MAX_PROBES][3];
    bool is_near[SOFTSIM_MAX_PROBES];
    if (!is_look_due(hybrid, middle, is_near)) {
        return;
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        hybrid->was_scanned[k] = is_near[k];
        if (is_near[k]) {
            ss_copy3(hybrid->scanned[k], middle[k]);
        }
    }
    const double reach = find_near(hybrid, middle, is_near);
    for (int32_t k = hybrid->wanted_count - 1; k >= 0; --k) {
        if (!(hybrid->distance[hybrid->wanted[k]] < hybrid->current_sleep_reach)) {
            unmark_wanted(hybrid, hybrid->wanted[k]);
        }
    }
    for (int32_t k = 0; k < hybrid->found_count; ++k) {
        const int32_t p = hybrid->found[k];
        if (hybrid->distance[p] < reach && hybrid->particle[p].wanted < 0) {
            mark_wanted(hybrid, p);
        }
    }
    forget_found(hybrid);
}

bool ss_hybrid_wake(ss_hybrid *hybrid)
{
    if (hybrid->is_all_awake || hybrid->step_counter++ % UPDATE_INTERVAL != 0) {
        return false;
    }
    update_wanted(hybrid);
    bool has_changed = hybrid->drifting_count > 0;
    if (hybrid->is_fading) {
        has_changed = fade(hybrid, BLEND_STEP) || has_changed;
    }
    if (hybrid->drifting_count > 0) {
        decay_offsets(hybrid);
    }
    if (hybrid->is_skin_fading) {
        has_changed = ss_hybrid_fade_skin(hybrid, (ss_real)BLEND_STEP) || has_changed;
    }
    ss_body_set_active_nodes(hybrid->body, hybrid->awake_count);
    return has_changed;
}

/* ---- all at once ---- */

static void finish_fades(ss_hybrid *hybrid)
{
    for (int32_t k = 0; k < 2 * MAX_RELEASE_UPDATES && hybrid->is_fading; ++k) {
        (void)fade(hybrid, 1.0);
    }
    (void)ss_hybrid_fade_skin(hybrid, 1);
    ss_body_set_active_nodes(hybrid->body, hybrid->awake_count);
}

void ss_hybrid_idle_all(ss_hybrid *hybrid)
{
    for (int32_t k = 0; k < hybrid->max_awake; ++k) {
        hybrid->idle[k] = hybrid->mesh->node_count + hybrid->max_awake - 1 - k;
    }
    hybrid->idle_count = hybrid->max_awake;
}

/* Volumes, masses and the order of idle nodes to the bits of the start, which adding and taking
 * away brings back but for rounding. */
static void begin_asleep(ss_hybrid *hybrid)
{
    const int32_t nodes = hybrid->mesh->node_count;
    ss_hybrid_idle_all(hybrid);
    for (int32_t c = 0; c < hybrid->cells.count; ++c) {
        hybrid->cell_volume[c] = hybrid->cell_asleep[c];
        ss_hybrid_write_cell(hybrid, c);
    }
    for (int32_t i = 0; i < nodes; ++i) {
        if (hybrid->mass_asleep[i] != ss_body_read_nodes(hybrid->body)->mass[i]) {
            ss_body_set_mass(hybrid->body, i, hybrid->mass_asleep[i]);
        }
    }
}

void ss_hybrid_reset_layer(ss_hybrid *hybrid)
{
    while (hybrid->wanted_count > 0 && !hybrid->is_all_awake) {
        unmark_wanted(hybrid, hybrid->wanted[hybrid->wanted_count - 1]);
    }
    for (int32_t p = 0; hybrid->is_all_awake && p < hybrid->layer->own_count; ++p) {
        if (hybrid->particle[p].wanted < 0) {
            mark_wanted(hybrid, p);
        }
    }
    finish_fades(hybrid);
    while (hybrid->drifting_count > 0) {
        const int32_t p = hybrid->drifting[--hybrid->drifting_count];
        memset(hybrid->offset + 4 * (ptrdiff_t)p, 0, 4 * sizeof *hybrid->offset);
        ss_hybrid_move_near(hybrid, p);
    }
    if (hybrid->awake_count == 0) {
        begin_asleep(hybrid);
    }
    memset(hybrid->was_scanned, 0, sizeof hybrid->was_scanned);
    ss_hybrid_show(hybrid, ss_body_read_nodes(hybrid->body)->u, hybrid->laid);
    hybrid->lay_batch = 0;
    hybrid->step_counter = 0;
    hybrid->current_sleep_reach = hybrid->sleep_reach;
    hybrid->is_skin_old = true;
    hybrid->close_count = hybrid->around_count = 0;
    memset(hybrid->was_listed, 0, sizeof hybrid->was_listed);
}

void ss_hybrid_wake_around(ss_hybrid *hybrid, int32_t s)
{
    const double *x = hybrid->mesh->position[hybrid->layer->skin_node[s]];
    const int32_t count = ss_point_grid_nearest(&hybrid->grid, x, hybrid->max_awake,
                                                (double)INFINITY, hybrid->found, hybrid->distance);
    for (int32_t k = 0; k < count; ++k) {
        mark_wanted(hybrid, hybrid->found[k]);
    }
    for (int32_t k = 0; k < hybrid->layer->own_count; ++k) {
        hybrid->distance[k] = (double)INFINITY;
    }
    finish_fades(hybrid);
}
