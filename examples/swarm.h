/* swarm.h: points that all move, and with them their triangulation and its cells, in a box of 2 by 1.
   Points drift in the double gyre of Shadden, Lekien and Marsden (2005, "Definition and properties of Lagrangian
   coherent structures", section 6), and towards the centroids of their cells, so that they stay evenly spread.
   A frame: new places; pbw_live_commit, which looks which facets still hold, and flips the others; the arrays; areas
   and centroids of the cells.  These are what pbw_cells.h gives, by one pass over the triangles: a triangle's centre,
   its corners and the middles of its edges part it into six right triangles, two for each corner's cell.  Their areas
   have signs, so obtuse triangles are no case.  Cells that a centre outside of the box or an edge of the hull is at
   are cut out of the box instead. */
#ifndef SWARM_H
#define SWARM_H
#include "pbw_cells.h"
#include "pbw_live.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double swarm_box[4] = { 0, 0, 2, 1 };

enum { SWARM_CORNERS = 60 };                         /* of a cell that is cut */
typedef struct swarm_cut { size_t count; double corner[SWARM_CORNERS + 1][2]; } swarm_cut;

typedef struct swarm {
    size_t count, room;                              /* of points; of cuts */
    double time, *points;
    double *areas, (*centroids)[2];                  /* of cells */
    double (*sums)[4];                               /* of cells: see swarm_add; not 0: it must be cut */
    pbw_index *number;                               /* of a cell's cut, counted from 1; 0: it is not cut */
    swarm_cut *cuts;
    pbw_options options;                             /* threads */
    pbw_live *live;
    pbw_mesh mesh;
} swarm;

static void swarm_free(swarm *s)
{
    free(s->points);
    free(s->areas);
    free(s->centroids);
    free(s->sums);
    free(s->number);
    free(s->cuts);
    pbw_live_free(s->live);
    pbw_free(&s->mesh);
    memset(s, 0, sizeof *s);
}

/* The gyre's velocity, where it sways by a = 0.25 sin(pi / 5 time): at most 0.1 pi times 1.5.  Single precision will
   do for a flow, and takes a fifth of the time. */
static void swarm_flow(double a, const double p[2], double v[2])
{
    const double pi = 3.14159265358979, b = 1 - 2 * a, f = (a * p[0] + b) * p[0], slope = 2 * a * p[0] + b;
    const float across = (float)(pi * f), up = (float)(pi * p[1]);
    v[0] = -0.1 * pi * (double)(sinf(across) * cosf(up));
    v[1] = 0.1 * pi * (double)(cosf(across) * sinf(up)) * slope;
}

/* Adds to a cell: 4 times the area, and, from its point, 24 times area times centroid. */
static inline void swarm_add(swarm *s, pbw_index v, double area, double x, double y)
{
    s->sums[v][0] += area;
    s->sums[v][1] += x;
    s->sums[v][2] += y;
}

/* Shares a triangle out among the cells of its corners; cells that must be cut are noted.  From corner i: the
   other corners are at b and c, twice the centre is x, y.  Right triangles at an edge e with area a add (0 + e / 2 +
   centre) a / 3 to the moment of the cell at its start. */
static void swarm_share(swarm *s, size_t triangle)
{
    const pbw_index *v = s->mesh.simplices + 3 * triangle, *neighbors = s->mesh.neighbors + 3 * triangle;
    const pbw_index i = v[0], j = v[1], k = v[2];
    const double *o = s->points + 2 * (size_t)i, *p = s->points + 2 * (size_t)j, *q = s->points + 2 * (size_t)k;
    const double bx = p[0] - o[0], by = p[1] - o[1], cx = q[0] - o[0], cy = q[1] - o[1];
    const double bb = bx * bx + by * by, cc = cx * cx + cy * cy, area = bx * cy - by * cx, scale = 1 / area;
    const double x = (bb * cy - cc * by) * scale, y = (cc * bx - bb * cx) * scale;
    const double at_b = 0.5 * (bx * y - by * x), at_c = 0.5 * (x * cy - y * cx), across = area - at_b - at_c;
    const double ux = at_b * bx, uy = at_b * by, vx = at_c * cx, vy = at_c * cy;
    const double wx = across * (cx - bx), wy = across * (cy - by);
    const double to_i = at_b + at_c, to_j = at_b + across, to_k = at_c + across;
    const double centre_x = o[0] + 0.5 * x, centre_y = o[1] + 0.5 * y;
    swarm_add(s, i, to_i, to_i * x + ux + vx, to_i * y + uy + vy);
    swarm_add(s, j, to_j, to_j * (x - bx - bx) - ux + wx, to_j * (y - by - by) - uy + wy);
    swarm_add(s, k, to_k, to_k * (x - cx - cx) - vx - wx, to_k * (y - cy - cy) - vy - wy);
    if (!(centre_x >= swarm_box[0] && centre_y >= swarm_box[1] && centre_x <= swarm_box[2]
          && centre_y <= swarm_box[3]) || (neighbors[0] | neighbors[1] | neighbors[2]) == PBW_NONE) {
        s->sums[i][3] = s->sums[j][3] = s->sums[k][3] = 1;
    }
}

/* Leaves of a cell what is nearer to p than to q (Sutherland and Hodgman 1974, "Reentrant polygon clipping").
   Returns 0 if it has too many corners then. */
static int swarm_clip(swarm_cut *cut, const double *p, const double *q)
{
    const double n[2] = { q[0] - p[0], q[1] - p[1] }, m[2] = { (p[0] + q[0]) / 2, (p[1] + q[1]) / 2 };
    const size_t count = cut->count;
    double old[SWARM_CORNERS][2];
    memcpy(old, cut->corner, count * sizeof *old);
    cut->count = 0;
    for (size_t i = 0; i < count; i++) {
        const double *a = old[i], *b = old[i + 1 < count ? i + 1 : 0];
        const double da = n[0] * (a[0] - m[0]) + n[1] * (a[1] - m[1]);
        const double db = n[0] * (b[0] - m[0]) + n[1] * (b[1] - m[1]);
        if (da <= 0) {
            memcpy(cut->corner[cut->count++], a, sizeof cut->corner[0]);
        }
        if ((da <= 0) != (db <= 0) && cut->count < SWARM_CORNERS) {
            cut->corner[cut->count][0] = a[0] + (b[0] - a[0]) * (da / (da - db));
            cut->corner[cut->count++][1] = a[1] + (b[1] - a[1]) * (da / (da - db));
        }
    }
    return cut->count < SWARM_CORNERS;
}

/* Area and centroid of a cut cell, seen from its point p. */
static void swarm_measure(const swarm_cut *cut, const double *p, double *area, double centroid[2])
{
    double twice = 0, x = 0, y = 0;
    for (size_t i = 0; i < cut->count; i++) {
        const double *a = cut->corner[i], *b = cut->corner[(i + 1) % cut->count];
        const double part = (a[0] - p[0]) * (b[1] - p[1]) - (a[1] - p[1]) * (b[0] - p[0]);
        twice += part;
        x += part * (a[0] - p[0] + b[0] - p[0]);
        y += part * (a[1] - p[1] + b[1] - p[1]);
    }
    *area = twice / 2;
    centroid[0] = p[0] + x / (3 * twice);
    centroid[1] = p[1] + y / (3 * twice);
}

/* The cells that must be cut begin as the box; numbers them. */
static pbw_status swarm_begin_cuts(swarm *s)
{
    size_t count = 0;
    for (size_t i = 0; i < s->count; i++) {
        s->number[i] = s->sums[i][3] > 0 ? (pbw_index)++count : 0;
    }
    if (count > s->room) {
        swarm_cut *more = (swarm_cut *)realloc(s->cuts, 2 * count * sizeof *more);
        if (more == NULL) {
            return PBW_ERROR_MEMORY;
        }
        s->cuts = more;
        s->room = 2 * count;
    }
    for (size_t i = 0; i < count; i++) {
        s->cuts[i].count = 4;
        for (int k = 0; k < 4; k++) {
            s->cuts[i].corner[k][0] = swarm_box[k == 1 || k == 2 ? 2 : 0];
            s->cuts[i].corner[k][1] = swarm_box[k >= 2 ? 3 : 1];
        }
    }
    return PBW_OK;
}

/* Cuts the cells at a triangle's edges, those that must be, by the bisectors of these: the cell at the start of an
   edge; that at its end where there is no triangle on the other side. */
static int swarm_cut_at(swarm *s, size_t triangle)
{
    const pbw_index *v = s->mesh.simplices + 3 * triangle, *neighbors = s->mesh.neighbors + 3 * triangle;
    int fits = 1;
    for (int k = 0; k < 3; k++) {
        const size_t i = v[k], j = v[(k + 1) % 3];
        if (s->number[i] > 0) {
            fits &= swarm_clip(s->cuts + s->number[i] - 1, s->points + 2 * i, s->points + 2 * j);
        }
        if (s->number[j] > 0 && neighbors[(k + 2) % 3] == PBW_NONE) {
            fits &= swarm_clip(s->cuts + s->number[j] - 1, s->points + 2 * j, s->points + 2 * i);
        }
    }
    return fits;
}

static pbw_status swarm_cells(swarm *s)
{
    pbw_status status;
    memset(s->sums, 0, s->count * sizeof *s->sums);
    for (size_t t = 0; t < s->mesh.simplex_count; t++) {
        swarm_share(s, t);
    }
    status = swarm_begin_cuts(s);
    for (size_t t = 0; t < s->mesh.simplex_count && status == PBW_OK; t++) {
        const pbw_index *v = s->mesh.simplices + 3 * t;
        if ((s->number[v[0]] | s->number[v[1]] | s->number[v[2]]) != 0 && !swarm_cut_at(s, t)) {
            status = PBW_ERROR_TOO_LARGE;
        }
    }
    for (size_t i = 0; i < s->count && status == PBW_OK; i++) {
        if (s->number[i] > 0) {
            swarm_measure(s->cuts + s->number[i] - 1, s->points + 2 * i, s->areas + i, s->centroids[i]);
        } else {
            const double scale = 1 / (6 * s->sums[i][0]);
            s->centroids[i][0] = s->points[2 * i] + s->sums[i][1] * scale;
            s->centroids[i][1] = s->points[2 * i + 1] + s->sums[i][2] * scale;
            s->areas[i] = 0.25 * s->sums[i][0];
        }
    }
    return status;
}

/* Triangulation and cells of the points where they are now. */
static pbw_status swarm_follow(swarm *s)
{
    pbw_status status = pbw_live_move(s->live, NULL, s->points, s->count);
    status = status != PBW_OK ? status : pbw_live_commit(s->live, NULL);
    pbw_free(&s->mesh);
    status = status != PBW_OK ? status : pbw_live_view(s->live, &s->mesh);
    return status != PBW_OK ? status : swarm_cells(s);
}

static double swarm_step(const swarm *s)
{
    return 0.025 * sqrt(2 / (double)s->count) / (0.15 * 3.14159265358979);
}

static double swarm_clamp(double x, double low, double high)
{
    x = x > low ? x : low;
    return x < high ? x : high;
}

/* New places for some points, none farther away than 0.03 of the mean distance of neighbours. */
static pbw_status swarm_move(void *arg, size_t from, size_t to)
{
    swarm *s = (swarm *)arg;
    const double step = swarm_step(s), most = 0.003 * sqrt(2 / (double)s->count);
    const double sway = 0.25 * sin(3.14159265358979 / 5 * s->time);
    for (size_t i = from; i < to; i++) {
        double v[2], *p = s->points + 2 * i;
        swarm_flow(sway, p, v);
        for (int k = 0; k < 2; k++) {
            p[k] += step * v[k] + swarm_clamp(0.01 * (s->centroids[i][k] - p[k]), -most, most);
            p[k] = swarm_clamp(p[k], swarm_box[k], swarm_box[2 + k]);
        }
    }
    return PBW_OK;
}

static pbw_status swarm_frame(swarm *s)
{
    const pbw_status status = pbw_for(&s->options, s->count, 4096, swarm_move, s);
    s->time += swarm_step(s);
    return status != PBW_OK ? status : swarm_follow(s);
}

/* Points at random, numbered along a curve, so that neighbours in the plane are neighbours in memory; then spread by
   five steps of Lloyd's relaxation.  swarm_free it, also after a failure. */
static pbw_status swarm_start(swarm *s, size_t count, int threads)
{
    unsigned long long random = 1;
    double *p = (double *)malloc((2 * count + 1) * sizeof *p);
    pbw_index *order = (pbw_index *)malloc((count + 1) * sizeof *order);
    pbw_status status = PBW_ERROR_MEMORY;
    memset(s, 0, sizeof *s);
    s->count = count;
    s->options.threads = threads;
    s->points = (double *)malloc((2 * count + 1) * sizeof *s->points);
    s->areas = (double *)malloc((count + 1) * sizeof *s->areas);
    s->centroids = (double (*)[2])malloc((count + 1) * sizeof *s->centroids);
    s->number = (pbw_index *)malloc((count + 1) * sizeof *s->number);
    s->sums = (double (*)[4])malloc((count + 1) * sizeof *s->sums);
    if (p != NULL && order != NULL && s->points != NULL && s->areas != NULL && s->centroids != NULL
        && s->number != NULL && s->sums != NULL) {
        for (size_t i = 0; i < 2 * count; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            p[i] = (double)(random >> 11) / 9007199254740992.0 * swarm_box[2 + i % 2];
        }
        status = pbw_order(2, p, count, &s->options, order);
    }
    for (size_t i = 0; i < count && status == PBW_OK; i++) {
        memcpy(s->points + 2 * i, p + 2 * (size_t)order[i], 2 * sizeof *p);
    }
    free(p);
    free(order);
    status = status != PBW_OK ? status : pbw_triangulate(2, s->points, NULL, count, &s->options, &s->mesh);
    status = status != PBW_OK ? status : pbw_live_create(&s->mesh, &s->options, &s->live);
    status = status != PBW_OK ? status : swarm_follow(s);
    for (int i = 0; i < 5 && status == PBW_OK; i++) {
        memcpy(s->points, s->centroids, 2 * count * sizeof *s->points);
        status = swarm_follow(s);
    }
    return status;
}
/* These cells by pbw_cells.h; what: PBW_CELLS_*. */
static pbw_status swarm_shapes(const swarm *s, unsigned what, pbw_cells *cells)
{
    pbw_domain domain = { 0 };
    domain.box = swarm_box;
    return pbw_cells_of(&s->mesh, &domain, what, NULL, cells);
}

/* Returns whether the triangulation, by its hash, and the cells are those of a rebuild. */
static int swarm_is_exact(const swarm *s)
{
    pbw_mesh mesh = { 0 };
    pbw_cells cells = { 0 };
    int same = pbw_triangulate(2, s->points, NULL, s->count, NULL, &mesh) == PBW_OK
            && pbw_hash(&mesh, NULL) == pbw_hash(&s->mesh, NULL) && swarm_shapes(s, 0, &cells) == PBW_OK;
    for (size_t i = 0; i < s->count && same; i++) {
        same = fabs(s->areas[i] - cells.volumes[i]) < 1e-11 * cells.volumes[i]
            && fabs(s->centroids[i][0] - cells.centroids[2 * i]) < 1e-11
            && fabs(s->centroids[i][1] - cells.centroids[2 * i + 1]) < 1e-11;
    }
    pbw_free(&mesh);
    pbw_cells_free(&cells);
    return same;
}
#endif /* SWARM_H */
