/* swarm.h: points that all move, and with them their triangulation and its cells, in a box of 2 by 1.
   Points drift in the double gyre of Shadden, Lekien and Marsden (2005, "Definition and properties of Lagrangian
   coherent structures", section 6), and towards the centroids of their cells, so that they stay evenly spread.
   A frame: new places; pbw_live_commit, which looks which facets still hold, and flips the others; the arrays; areas
   and centroids of the cells. */
#ifndef SWARM_H
#define SWARM_H
#include "pbw_cells.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double swarm_box[4] = { 0, 0, 2, 1 };

typedef struct swarm {
    size_t count;
    double time, *points;
    pbw_live *live;
    pbw_mesh mesh;
    pbw_cells cells;
} swarm;

static void swarm_free(swarm *s)
{
    free(s->points);
    pbw_live_free(s->live);
    pbw_free(&s->mesh);
    pbw_cells_free(&s->cells);
    memset(s, 0, sizeof *s);
}

/* The gyre's velocity: at most 0.1 pi times 1.5. */
static void swarm_flow(double time, const double p[2], double v[2])
{
    const double pi = 3.14159265358979, a = 0.25 * sin(pi / 5 * time), b = 1 - 2 * a;
    const double f = (a * p[0] + b) * p[0], slope = 2 * a * p[0] + b;
    v[0] = -0.1 * pi * sin(pi * f) * cos(pi * p[1]);
    v[1] = 0.1 * pi * cos(pi * f) * sin(pi * p[1]) * slope;
}

/* Triangulation and cells of the points where they are now. */
static pbw_status swarm_follow(swarm *s, unsigned what)
{
    pbw_domain domain = { 0 };
    pbw_status status = pbw_live_move(s->live, NULL, s->points, s->count);
    domain.box = swarm_box;
    status = status != PBW_OK ? status : pbw_live_commit(s->live, NULL);
    pbw_free(&s->mesh);
    pbw_cells_free(&s->cells);
    status = status != PBW_OK ? status : pbw_live_view(s->live, &s->mesh);
    return status != PBW_OK ? status : pbw_cells_of(&s->mesh, &domain, what, NULL, &s->cells);
}

/* A frame, in which no point goes farther than 0.03 of the mean distance of neighbours; what: PBW_CELLS_*. */
static pbw_status swarm_frame(swarm *s, unsigned what)
{
    const double edge = sqrt(2 / (double)s->count), step = 0.025 * edge / (0.15 * 3.14159265358979);
    for (size_t i = 0; i < s->count; i++) {
        double v[2], *p = s->points + 2 * i;
        swarm_flow(s->time, p, v);
        for (int k = 0; k < 2; k++) {
            const double off = s->cells.centroids[2 * i + (size_t)k] - p[k], most = 0.003 * edge;
            p[k] += step * v[k] + fmin(fmax(0.01 * off, -most), most);
            p[k] = fmin(fmax(p[k], swarm_box[k]), swarm_box[2 + k]);
        }
    }
    s->time += step;
    return swarm_follow(s, what);
}

/* Points at random, numbered along a curve, so that neighbours in the plane are neighbours in memory; then spread by
   five steps of Lloyd's relaxation.  swarm_free it, also after a failure. */
static pbw_status swarm_start(swarm *s, size_t count)
{
    unsigned long long random = 1;
    double *p = (double *)malloc((2 * count + 1) * sizeof *p);
    pbw_index *order = (pbw_index *)malloc((count + 1) * sizeof *order);
    pbw_status status = PBW_ERROR_MEMORY;
    memset(s, 0, sizeof *s);
    s->count = count;
    s->points = (double *)malloc((2 * count + 1) * sizeof *s->points);
    if (p != NULL && order != NULL && s->points != NULL) {
        for (size_t i = 0; i < 2 * count; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            p[i] = (double)(random >> 11) / 9007199254740992.0 * swarm_box[2 + i % 2];
        }
        status = pbw_order(2, p, count, NULL, order);
    }
    for (size_t i = 0; i < count && status == PBW_OK; i++) {
        memcpy(s->points + 2 * i, p + 2 * (size_t)order[i], 2 * sizeof *p);
    }
    free(p);
    free(order);
    status = status != PBW_OK ? status : pbw_triangulate(2, s->points, NULL, count, NULL, &s->mesh);
    status = status != PBW_OK ? status : pbw_live_create(&s->mesh, NULL, &s->live);
    status = status != PBW_OK ? status : swarm_follow(s, 0);
    for (int i = 0; i < 5 && status == PBW_OK; i++) {
        memcpy(s->points, s->cells.centroids, 2 * count * sizeof *s->points);
        status = swarm_follow(s, 0);
    }
    return status;
}
#endif /* SWARM_H */
