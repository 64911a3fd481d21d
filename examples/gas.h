/* gas.h: a gas on a moving periodic Voronoi mesh in the plane, as Springel does it: 2010, "E pur si muove:
   Galilean-invariant cosmological hydrodynamical simulations on a moving mesh", sections 3.1 to 3.5.
   Each cell has an amount of mass, momentum and energy.  In a step, amounts flow through the facets between cells,
   and points move about as the gas does.  What leaves a cell enters its neighbour: sums change by rounding alone. */
#ifndef GAS_H
#define GAS_H
#include "pbw_cells.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct gas {
    size_t count;
    double box[4], gamma, time;
    double (*points)[2], (*motion)[2];     /* per cell: its point, and the point's velocity */
    double (*amounts)[4];                  /* mass, momentum x and y, energy */
    double (*states)[4];                   /* density, velocity x and y, pressure */
    double (*slopes)[4][2];                /* of the states */
    pbw_cells cells;
    pbw_options options;
} gas;

static double gas_sound(const gas *g, const double state[4])
{
    return sqrt(g->gamma * state[3] / state[0]);
}

static void gas_free(gas *g)
{
    free(g->points);
    free(g->motion);
    free(g->amounts);
    free(g->states);
    free(g->slopes);
    pbw_cells_free(&g->cells);
    memset(g, 0, sizeof *g);
}

static pbw_status gas_mesh(gas *g)
{
    pbw_domain domain = { 0 };
    pbw_status status;
    domain.box = g->box;
    domain.periodic = 3;
    pbw_cells_free(&g->cells);
    for (size_t i = 0; i < g->count; i++) {                    /* back into the box */
        for (int k = 0; k < 2; k++) {
            const double size = g->box[2 + k] - g->box[k], x = g->points[i][k];
            g->points[i][k] = x - size * floor((x - g->box[k]) / size);
        }
    }
    status = pbw_cells_periodic(2, g->points[0], NULL, g->count, &domain, PBW_CELLS_SHAPES, &g->options, &g->cells);
    return status;
}

/* A facet of cell i: its neighbour, the way there from point to point, middle (relative to the point), and length. */
typedef struct gas_facet { size_t i, j; double way[2], distance, middle[2], length; } gas_facet;

static gas_facet gas_facet_of(const gas *g, size_t i, size_t facet)
{
    const pbw_cells *c = &g->cells;
    const pbw_index *end = c->loops + c->loop_first[facet];
    const double *a = c->vertices + 2 * (size_t)end[0], *b = c->vertices + 2 * (size_t)end[1];
    gas_facet f;
    f.i = i;
    f.j = c->neighbors[facet];
    f.length = c->areas[facet];
    for (int k = 0; k < 2; k++) {
        f.way[k] = g->points[f.j][k] + c->shifts[2 * facet + (size_t)k] * (g->box[2 + k] - g->box[k])
                 - g->points[i][k];
        f.middle[k] = (a[k] + b[k]) / 2 - g->points[i][k];
    }
    f.distance = hypot(f.way[0], f.way[1]);
    return f;
}

/* States from amounts; slopes by the sum over facets of section 3.3, exact for linear states; limited so that no
   facet sees a state beyond those of the cells around. */
static void gas_states(gas *g)
{
    for (size_t i = 0; i < g->count; i++) {
        const double *q = g->amounts[i], volume = g->cells.volumes[i];
        double *s = g->states[i];
        s[0] = q[0] / volume;
        s[1] = q[1] / q[0];
        s[2] = q[2] / q[0];
        s[3] = (g->gamma - 1) * (q[3] - (q[1] * q[1] + q[2] * q[2]) / (2 * q[0])) / volume;
    }
}

static void gas_slopes(gas *g, size_t i)
{
    const double *centre = g->cells.centroids + 2 * i, *mine = g->states[i];
    double slope[4][2] = { { 0 } }, least[4], most[4], share[4] = { 1, 1, 1, 1 };
    memcpy(least, mine, sizeof least);
    memcpy(most, mine, sizeof most);
    for (size_t f = g->cells.first[i]; f < g->cells.first[i + 1]; f++) {
        const gas_facet facet = gas_facet_of(g, i, f);
        const double *other = g->states[facet.j], scale = facet.length / (facet.distance * g->cells.volumes[i]);
        for (int s = 0; s < 4; s++) {
            for (int k = 0; k < 2; k++) {
                const double aside = facet.middle[k] - facet.way[k] / 2;
                slope[s][k] += scale * ((other[s] - mine[s]) * aside + (mine[s] + other[s]) / 2 * facet.way[k]);
            }
            least[s] = fmin(least[s], other[s]);
            most[s] = fmax(most[s], other[s]);
        }
    }
    for (size_t f = g->cells.first[i]; f < g->cells.first[i + 1]; f++) {
        const gas_facet facet = gas_facet_of(g, i, f);
        for (int s = 0; s < 4; s++) {
            const double change = slope[s][0] * (facet.middle[0] - (centre[0] - g->points[i][0]))
                                + slope[s][1] * (facet.middle[1] - (centre[1] - g->points[i][1]));
            const double room = change > 0 ? most[s] - mine[s] : least[s] - mine[s];
            share[s] = fabs(change) > fabs(room) ? fmin(share[s], room / change) : share[s];
        }
    }
    for (int s = 0; s < 4; s++) {
        g->slopes[i][s][0] = share[s] * slope[s][0];
        g->slopes[i][s][1] = share[s] * slope[s][1];
    }
}

/* Points move with the gas, and towards the centroid where they are far from it, so that cells stay round
   (section 4, with eta = 0.25). */
static void gas_motion(gas *g, size_t i)
{
    const double *centre = g->cells.centroids + 2 * i, *s = g->states[i];
    const double off[2] = { centre[0] - g->points[i][0], centre[1] - g->points[i][1] };
    const double distance = hypot(off[0], off[1]), far = distance / (0.25 * sqrt(g->cells.volumes[i] / 3.14159265));
    const double pull = far < 0.9 ? 0 : far > 1.1 ? 1 : (far - 0.9) / 0.2;
    for (int k = 0; k < 2; k++) {
        g->motion[i][k] = s[1 + k] + (pull > 0 ? pull * gas_sound(g, s) * off[k] / distance : 0);
    }
}

/* The state of cell i at a facet, half a step later, for somebody who moves with the facet; from: the way there from
   the cell's centroid. */
static void gas_ahead(const gas *g, size_t i, const double from[2], const double frame[2], double half, double out[4])
{
    const double *s = g->states[i], (*d)[2] = (const double (*)[2])g->slopes[i];
    const double u = s[1] - frame[0], v = s[2] - frame[1], spread = d[1][0] + d[2][1];
    const double rate[4] = { -(u * d[0][0] + v * d[0][1] + s[0] * spread),
                             -(u * d[1][0] + v * d[1][1] + d[3][0] / s[0]),
                             -(u * d[2][0] + v * d[2][1] + d[3][1] / s[0]),
                             -(u * d[3][0] + v * d[3][1] + g->gamma * s[3] * spread) };
    for (int k = 0; k < 4; k++) {
        out[k] = s[k] + d[k][0] * from[0] + d[k][1] * from[1] + half * rate[k];
    }
    if (!(out[0] > 0 && out[3] > 0)) {                         /* too steep: the cell's own state */
        memcpy(out, s, 4 * sizeof *out);
    }
    out[1] -= frame[0];
    out[2] -= frame[1];
}

/* What flows along x from a state into another, per length and time: the HLLC solver (Toro, Spruce and Speares 1994,
   "Restoration of the contact surface in the HLL-Riemann solver"). */
static void gas_flow(const gas *g, const double left[4], const double right[4], double flow[4])
{
    const double cl = gas_sound(g, left), cr = gas_sound(g, right);
    const double sl = fmin(left[1] - cl, right[1] - cr), sr = fmax(left[1] + cl, right[1] + cr);
    const double ml = left[0] * (sl - left[1]), mr = right[0] * (sr - right[1]);
    const double middle = (right[3] - left[3] + left[1] * ml - right[1] * mr) / (ml - mr);
    const double *s = middle >= 0 ? left : right, fast = middle >= 0 ? sl : sr;
    const double energy = s[3] / (g->gamma - 1) + s[0] * (s[1] * s[1] + s[2] * s[2]) / 2;
    flow[0] = s[0] * s[1];
    flow[1] = flow[0] * s[1] + s[3];
    flow[2] = flow[0] * s[2];
    flow[3] = (energy + s[3]) * s[1];
    if (sl < 0 && sr > 0) {                                    /* between the outer waves */
        const double star = s[0] * (fast - s[1]) / (fast - middle);
        flow[0] += fast * (star - s[0]);
        flow[1] += fast * (star * middle - s[0] * s[1]);
        flow[2] += fast * (star * s[2] - s[0] * s[2]);
        flow[3] += fast * (star * (energy / s[0] + (middle - s[1]) * (middle + s[3] / (s[0] * (fast - s[1]))))
                           - energy);
    }
}

/* Lets amounts flow through a facet for a time. */
static void gas_exchange(gas *g, const gas_facet *f, double time)
{
    const double n[2] = { f->way[0] / f->distance, f->way[1] / f->distance };
    const double *wi = g->motion[f->i], *wj = g->motion[f->j];
    double aside = 0, frame[2], from[2][2], state[2][4], flow[4];
    for (int k = 0; k < 2; k++) {                              /* the facet's own velocity, section 3.1 */
        aside += (wi[k] - wj[k]) * (f->middle[k] - f->way[k] / 2) / f->distance;
    }
    for (int k = 0; k < 2; k++) {
        frame[k] = (wi[k] + wj[k]) / 2 + aside * n[k];
        from[0][k] = f->middle[k] - (g->cells.centroids[2 * f->i + (size_t)k] - g->points[f->i][k]);
        from[1][k] = f->middle[k] - f->way[k] - (g->cells.centroids[2 * f->j + (size_t)k] - g->points[f->j][k]);
    }
    for (int side = 0; side < 2; side++) {
        double *s = state[side];
        gas_ahead(g, side ? f->j : f->i, from[side], frame, time / 2, s);
        const double across = n[0] * s[1] + n[1] * s[2];
        s[2] = n[0] * s[2] - n[1] * s[1];
        s[1] = across;
    }
    gas_flow(g, state[0], state[1], flow);
    const double x = n[0] * flow[1] - n[1] * flow[2], y = n[1] * flow[1] + n[0] * flow[2];
    flow[3] += frame[0] * x + frame[1] * y + (frame[0] * frame[0] + frame[1] * frame[1]) / 2 * flow[0];
    flow[1] = x + frame[0] * flow[0];
    flow[2] = y + frame[1] * flow[0];
    for (int k = 0; k < 4; k++) {
        g->amounts[f->i][k] -= time * f->length * flow[k];
        g->amounts[f->j][k] += time * f->length * flow[k];
    }
}

/* Points of a lattice, moved a little at random.  Without memory, points is NULL. */
static gas gas_lattice(size_t columns, size_t rows, double wide, double high, double gamma)
{
    unsigned long long random = 1;
    gas g;
    memset(&g, 0, sizeof g);
    g.count = columns * rows;
    g.box[2] = wide;
    g.box[3] = high;
    g.gamma = gamma;
    g.points = (double (*)[2])malloc(g.count * sizeof *g.points);
    for (size_t i = 0; i < g.count && g.points != NULL; i++) {
        const size_t at[2] = { i % columns, i / columns };
        for (int k = 0; k < 2; k++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            g.points[i][k] = g.box[2 + k] * ((double)at[k] + 0.3 + 0.4 * (double)(random >> 33) / 2147483648.0)
                           / (double)(k ? rows : columns);
        }
    }
    return g;
}

/* A gas of states that a function of the place gives.  gas_free it, also after a failure. */
static pbw_status gas_start(gas *g, void (*initial)(const double place[2], double state[4]))
{
    g->motion = (double (*)[2])calloc(g->count, sizeof *g->motion);
    g->amounts = (double (*)[4])calloc(g->count, sizeof *g->amounts);
    g->states = (double (*)[4])calloc(g->count, sizeof *g->states);
    g->slopes = (double (*)[4][2])calloc(g->count, sizeof *g->slopes);
    if (g->points == NULL || g->motion == NULL || g->amounts == NULL || g->states == NULL || g->slopes == NULL) {
        return PBW_ERROR_MEMORY;
    }
    const pbw_status status = gas_mesh(g);
    for (size_t i = 0; i < g->count && status == PBW_OK; i++) {
        double s[4], *q = g->amounts[i];
        const double volume = g->cells.volumes[i];
        initial(g->cells.centroids + 2 * i, s);
        q[0] = s[0] * volume;
        q[1] = q[0] * s[1];
        q[2] = q[0] * s[2];
        q[3] = volume * s[3] / (g->gamma - 1) + q[0] * (s[1] * s[1] + s[2] * s[2]) / 2;
    }
    gas_states(g);
    return status;
}

/* One step, as long as is stable, but not beyond a time.  Leaves mesh and states of that time. */
static pbw_status gas_step(gas *g, double until)
{
    double step = until - g->time;
    for (size_t i = 0; i < g->count; i++) {
        gas_slopes(g, i);
        gas_motion(g, i);
        const double *s = g->states[i], u = s[1] - g->motion[i][0], v = s[2] - g->motion[i][1];
        step = fmin(step, 0.3 * sqrt(g->cells.volumes[i] / 3.14159265) / (gas_sound(g, s) + hypot(u, v)));
    }
    for (size_t i = 0; i < g->count; i++) {
        for (size_t f = g->cells.first[i]; f < g->cells.first[i + 1]; f++) {
            const gas_facet facet = gas_facet_of(g, i, f);
            if (facet.i < facet.j) {                           /* once; a cell that meets itself exchanges nothing */
                gas_exchange(g, &facet, step);
            }
        }
    }
    for (size_t i = 0; i < g->count; i++) {
        g->points[i][0] += step * g->motion[i][0];
        g->points[i][1] += step * g->motion[i][1];
    }
    g->time = step < until - g->time ? g->time + step : until;
    const pbw_status status = gas_mesh(g);
    gas_states(g);
    return status;
}

static double gas_sum(const gas *g, int which)
{
    double sum = 0;
    for (size_t i = 0; i < g->count; i++) {
        sum += g->amounts[i][which];
    }
    return sum;
}

/* Steps to a time.  Returns 0 and prints why if that fails, or if mass, momentum or energy is not kept to 1e-12. */
static int gas_run(gas *g, double until)
{
    pbw_status status = PBW_OK;
    double before[4];
    for (int k = 0; k < 4; k++) {
        before[k] = gas_sum(g, k);
    }
    while (g->time < until && status == PBW_OK) {
        status = gas_step(g, until);
    }
    for (int k = 0; k < 4 && status == PBW_OK; k++) {
        const double lost = fabs(gas_sum(g, k) - before[k]) / before[k == 0 ? 0 : 3];
        if (!(lost <= 1e-12)) {
            printf("of mass, momentum x, y, energy, number %d changed by %g\n", k, lost);
            return 0;
        }
    }
    if (status != PBW_OK) {
        printf("%s\n", pbw_status_string(status));
    }
    return status == PBW_OK;
}
#endif /* GAS_H */
