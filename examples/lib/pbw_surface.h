/* pbw_surface.h - v0.2.0 - nearest points, crossings and the inside of a triangulated surface - MIT-0

   QUICK START
   In one source file, define PBW_SURFACE_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file.

       pbw_surface surface = {0};
       double place[3];
       pbw_surface_create(points, point_count, triangles, triangle_count, NULL, &surface);
       pbw_surface_closest(&surface, p, HUGE_VAL, place);            // the nearest point of the surface
       pbw_surface_inside(&surface, p);                              // 1: p is inside of a closed surface
       pbw_surface_free(&surface);

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>arrays       types of growing arrays
     >>vectors      vectors and triangles in space
     >>tree         boxes over the triangles
     >>queries      nearest places, crossings, the inside
     >>seam         private names that other headers use

   FUNCTIONS
     pbw_surface_create   a tree over triangles
     pbw_surface_closest  the nearest place of the surface
     pbw_surface_meets    the first triangle that a segment meets
     pbw_surface_inside   whether a point is inside
     pbw_surface_turns    how many shells are around a point, exactly
     pbw_surface_winding  the winding number, of open surfaces too
     pbw_surface_free     frees the tree

   HOW
   Boxes in a binary tree over the triangles in the order of a Hilbert curve: leaves of four triangles, all levels
   complete, so that no links are needed.  Queries write nothing: any number of threads may run them at once on one
   surface.  pbw_mesh3.h and pbw_improve.h do so unless options.threads is 1, and call `value`, `project` and size
   callbacks from several threads at once.

   PROMISES  (tests/test_improve.c guards them)
     inside      exact for a closed surface: the parity of a ray is counted by exact signs, and a ray through edges or
                 corners is perturbed symbolically
     closest     the nearest point up to rounding
     bounded     no recursion; at most 110 bytes a triangle beside the caller's arrays

   CONFIGURATION MACROS
     PBW_SURFACE_IMPLEMENTATION  in one source file: compile the implementation there
     PBWSURFACEDEF               everywhere: your own linkage for the functions, for example static
*/
#ifndef PBW_SURFACE_H
#define PBW_SURFACE_H
#ifndef PBW_H
#include "pbw.h"
#endif

#ifndef PBWSURFACEDEF
#define PBWSURFACEDEF extern
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbw_surface {               /* start from {0}; pbw_surface_free when done */
    size_t point_count, triangle_count;
    const double *points;                  /* the caller's, 3 coordinates each: they must outlive the surface */
    const pbw_index *triangles;            /* the caller's, 3 ids each */
    void *memory;                          /* private */
} pbw_surface;

/* Builds the tree.  Returns PBW_ERROR_ARGUMENT for ids out of range, PBW_ERROR_NOT_FINITE, or what pbw_order fails
   with; no triangles are fine. */
PBWSURFACEDEF pbw_status pbw_surface_create(const double *points, size_t point_count, const pbw_index *triangles,
                                            size_t triangle_count, const pbw_options *options, pbw_surface *surface);
/* Returns the triangle nearest to p, and in `place` its point there; PBW_NONE if none is nearer than limit. */
PBWSURFACEDEF pbw_index pbw_surface_closest(const pbw_surface *surface, const double p[3], double limit,
                                            double place[3]);
/* Returns the first triangle that the segment from a to b meets, and in *where how far along, 0 to 1, rounded;
   PBW_NONE if it meets none. */
PBWSURFACEDEF pbw_index pbw_surface_meets(const pbw_surface *surface, const double a[3], const double b[3],
                                          double *where);
/* Returns 1 if a ray from p crosses the surface an odd number of times, else 0; for points on the surface either. */
PBWSURFACEDEF int pbw_surface_inside(const pbw_surface *surface, const double p[3]);
/* Returns how many more triangles a ray from p leaves by their fronts than by their backs: for closed shells turned
   outward, the number of shells around p, by exact signs. */
PBWSURFACEDEF long pbw_surface_turns(const pbw_surface *surface, const double p[3]);
/* Returns the winding number of the surface around p: for a closed surface turned outward 1 inside and 0 outside; for
   an open one a fraction, smooth across its holes, so that above 1/2 is a fair inside.  Triangles must be oriented
   alike. Far parts are approximated by dipoles: the error is about 0.01. */
PBWSURFACEDEF double pbw_surface_winding(const pbw_surface *surface, const double p[3]);
PBWSURFACEDEF void pbw_surface_free(pbw_surface *surface);   /* fine on {0}, fine twice */

#ifdef __cplusplus
}
#endif
#endif /* PBW_SURFACE_H */

#if defined(PBW_SURFACE_IMPLEMENTATION) && !defined(PBWSURFACE__IMPLEMENTED)
#define PBWSURFACE__IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

PBW_CONTRACTION_OFF                        /* fused operations would give other coordinates */

#if defined(__GNUC__)                      /* functions of >>seam that this file has no use for */
#define PBWSF__SHARED __attribute__((unused))
#else
#define PBWSF__SHARED
#endif

/* ------------------------------------------------------------------------------------------------------
   >>arrays       Types of growing arrays.
   Holds: the arrays of a call, and what surfaces and meshes made in it hold, count in one pbw_memory.
   ------------------------------------------------------------------------------------------------------ */
typedef double pbwsf__vector[3];
typedef pbw_index pbwsf__pair[2], pbwsf__triple[3], pbwsf__quadruple[4];
typedef PBW_ARRAY(pbw_index) pbwsf__indices;
typedef PBW_ARRAY(size_t) pbwsf__counts;
typedef PBW_ARRAY(double) pbwsf__numbers;
typedef PBW_ARRAY(unsigned char) pbwsf__flags;
typedef PBW_ARRAY(pbwsf__vector) pbwsf__vectors;
typedef PBW_ARRAY(pbwsf__pair) pbwsf__pairs;
typedef PBW_ARRAY(pbwsf__triple) pbwsf__triples;
typedef PBW_ARRAY(pbwsf__quadruple) pbwsf__quadruples;

/* ------------------------------------------------------------------------------------------------------
   >>vectors      Vectors and triangles in space.
   In: coordinates.  Out: coordinates, or a number.
   ------------------------------------------------------------------------------------------------------ */
static double pbwsf__dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void pbwsf__minus(const double a[3], const double b[3], double out[3])
{
    out[0] = a[0] - b[0];
    out[1] = a[1] - b[1];
    out[2] = a[2] - b[2];
}

static void pbwsf__cross(const double a[3], const double b[3], double out[3])
{
    const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

static double pbwsf__distance(const double a[3], const double b[3])
{
    double d[3];
    pbwsf__minus(a, b, d);
    return sqrt(pbwsf__dot(d, d));
}

/* The normal of the triangle, twice its area long. */
static void pbwsf__normal(const double a[3], const double b[3], const double c[3], double out[3])
{
    double u[3], v[3];
    pbwsf__minus(b, a, u);
    pbwsf__minus(c, a, v);
    pbwsf__cross(u, v, out);
}

/* a + t (b - a). */
static void pbwsf__between(const double a[3], const double b[3], double t, double out[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        out[k] = a[k] + t * (b[k] - a[k]);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>tree         Boxes over the triangles.
   In: a surface.  Out: its tree.
   Holds: node i has the children 2 i + 1 and 2 i + 2; node first_leaf + j has the triangles 4 j .. 4 j + 3 of
   `order`.  The box of a node without triangles is empty: its low corner is above its high one.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWSF__LEAF = 4, PBWSF__DEPTH = 64 };

typedef struct pbwsf__box {
    double low[3], high[3];
    double area[3];                        /* sum of the triangles' normals, half of each cross product */
} pbwsf__box;

typedef struct pbwsf__tree {
    pbw_memory memory;
    PBW_ARRAY(pbw_index) order;
    PBW_ARRAY(pbwsf__box) boxes;
    size_t first_leaf, nodes;
} pbwsf__tree;

static const double *pbwsf__corner(const pbw_surface *s, pbw_index triangle, int k)
{
    return s->points + 3 * (size_t)s->triangles[3 * (size_t)triangle + (size_t)k];
}

/* Leaf i has the triangles order[first_of] .. order[end_of - 1]. */
static size_t pbwsf__first_of(const pbwsf__tree *tree, size_t i)
{
    return (i - tree->first_leaf) * PBWSF__LEAF;
}

static size_t pbwsf__end_of(const pbw_surface *s, const pbwsf__tree *tree, size_t i)
{
    const size_t end = (i - tree->first_leaf + 1) * PBWSF__LEAF;
    return end < s->triangle_count ? end : s->triangle_count;
}

/* The normal of a triangle, twice its area long. */
static void pbwsf__normal_of(const pbw_surface *s, pbw_index triangle, double out[3])
{
    pbwsf__normal(pbwsf__corner(s, triangle, 0), pbwsf__corner(s, triangle, 1), pbwsf__corner(s, triangle, 2), out);
}

static void pbwsf__box_clear(pbwsf__box *box)
{
    int k;
    for (k = 0; k < 3; k++) {
        box->low[k] = HUGE_VAL;
        box->high[k] = -HUGE_VAL;
        box->area[k] = 0;
    }
}

static void pbwsf__box_add(pbwsf__box *box, const double low[3], const double high[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        box->low[k] = low[k] < box->low[k] ? low[k] : box->low[k];
        box->high[k] = high[k] > box->high[k] ? high[k] : box->high[k];
    }
}

static void pbwsf__fill_boxes(const pbw_surface *s, pbwsf__tree *tree)
{
    pbwsf__box *box = tree->boxes.at;
    const pbw_index *order = tree->order.at;
    size_t i, k;
    for (i = tree->nodes; i-- > 0;) {
        pbwsf__box_clear(box + i);
        if (i < tree->first_leaf) {
            pbwsf__box_add(box + i, box[2 * i + 1].low, box[2 * i + 1].high);
            pbwsf__box_add(box + i, box[2 * i + 2].low, box[2 * i + 2].high);
            for (k = 0; k < 3; k++) {
                box[i].area[k] = box[2 * i + 1].area[k] + box[2 * i + 2].area[k];
            }
            continue;
        }
        for (k = pbwsf__first_of(tree, i); k < pbwsf__end_of(s, tree, i); k++) {
            double n[3];
            int j;
            pbwsf__normal_of(s, order[k], n);
            for (j = 0; j < 3; j++) {
                pbwsf__box_add(box + i, pbwsf__corner(s, order[k], j), pbwsf__corner(s, order[k], j));
                box[i].area[j] += 0.5 * n[j];
            }
        }
    }
}

/* The order along a Hilbert curve through the triangles' centroids. */
static pbw_status pbwsf__sort(const pbw_surface *s, const pbw_options *options, pbwsf__tree *tree)
{
    PBW_ARRAY(double) middle = { NULL, 0, 0 };
    pbw_options own;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, k;
    memset(&own, 0, sizeof own);
    if (options != NULL) {
        own.threads = options->threads;
        own.resize = options->resize;
        own.resize_user = options->resize_user;
        own.run = options->run;
        own.run_user = options->run_user;
    }
    if (PBW_FIT(&tree->memory, tree->order, s->triangle_count + 1)
        && PBW_FIT(&tree->memory, middle, 3 * (s->triangle_count + 1))) {
        for (i = 0; i < s->triangle_count; i++) {
            for (k = 0; k < 3; k++) {
                const pbw_index *c = s->triangles + 3 * i;
                middle.at[3 * i + k] = s->points[3 * (size_t)c[0] + k] / 3 + s->points[3 * (size_t)c[1] + k] / 3
                                     + s->points[3 * (size_t)c[2] + k] / 3;
            }
        }
        own.memory_limit = pbw_memory_left(&tree->memory);
        status = pbw_order(3, middle.at, s->triangle_count, &own, tree->order.at);
        status = status == PBW_DEGENERATE ? PBW_OK : status;
    }
    PBW_RELEASE(&tree->memory, middle);
    return status;
}

static pbw_status pbwsf__build(const pbw_options *options, pbw_surface *surface)
{
    pbwsf__tree *tree = (pbwsf__tree *)surface->memory;
    pbw_status status = pbwsf__sort(surface, options, tree);
    size_t leaves = 1;
    while (leaves * PBWSF__LEAF < surface->triangle_count) {
        leaves *= 2;
    }
    tree->first_leaf = leaves - 1;
    tree->nodes = 2 * leaves - 1;
    if (status != PBW_OK) {
        return status;
    }
    if (!PBW_FIT(&tree->memory, tree->boxes, tree->nodes)) {
        return PBW_ERROR_MEMORY;
    }
    pbwsf__fill_boxes(surface, tree);
    return PBW_OK;
}

PBWSURFACEDEF pbw_status pbw_surface_create(const double *points, size_t point_count, const pbw_index *triangles,
                                            size_t triangle_count, const pbw_options *options, pbw_surface *surface)
{
    pbw_memory memory;
    pbwsf__tree *tree;
    pbw_status status;
    size_t i;
    if (surface == NULL || (triangle_count > 0 && (points == NULL || triangles == NULL))) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(surface, 0, sizeof *surface);
    for (i = 0; i < 3 * triangle_count; i++) {
        if (triangles[i] >= point_count) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    for (i = 0; i < 3 * point_count; i++) {
        if (!(fabs(points[i]) <= 1e300)) {
            return PBW_ERROR_NOT_FINITE;
        }
    }
    pbw_memory_start(&memory, options);
    tree = (pbwsf__tree *)pbw_memory_resize(&memory, NULL, 0, 1, sizeof *tree);
    if (tree == NULL) {
        return PBW_ERROR_MEMORY;
    }
    memset(tree, 0, sizeof *tree);
    tree->memory = memory;
    surface->points = points;
    surface->point_count = point_count;
    surface->triangles = triangles;
    surface->triangle_count = triangle_count;
    surface->memory = tree;
    status = pbwsf__build(options, surface);
    if (status != PBW_OK) {
        pbw_surface_free(surface);
    }
    return status;
}

/* Returns how many bytes a surface holds. */
PBWSF__SHARED static size_t pbwsf__bytes(const pbw_surface *surface)
{
    return surface->memory != NULL ? ((const pbwsf__tree *)surface->memory)->memory.used : 0;
}

PBWSURFACEDEF void pbw_surface_free(pbw_surface *surface)
{
    if (surface != NULL && surface->memory != NULL) {
        pbwsf__tree *tree = (pbwsf__tree *)surface->memory;
        pbw_memory memory = tree->memory;
        PBW_RELEASE(&memory, tree->order);
        PBW_RELEASE(&memory, tree->boxes);
        (void)pbw_memory_resize(&memory, tree, 1, 0, sizeof *tree);
    }
    if (surface != NULL) {
        memset(surface, 0, sizeof *surface);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>queries      Nearest places, crossings, and the inside.
   In: a surface and its tree; points.  Out: triangles, places, numbers.
   ------------------------------------------------------------------------------------------------------ */

/* The nearest point of a triangle: in the Voronoi region of a corner, of an edge, or of the inside (Ericson 2005,
   "Real-Time Collision Detection", 5.1.5). */
static void pbwsf__nearest_in(const double *a, const double *b, const double *c, const double *p, double *out)
{
    double ab[3], ac[3], ap[3], bp[3], cp[3], d1, d2, d3, d4, d5, d6, va, vb, vc, sum;
    int k;
    pbwsf__minus(b, a, ab);
    pbwsf__minus(c, a, ac);
    pbwsf__minus(p, a, ap);
    pbwsf__minus(p, b, bp);
    pbwsf__minus(p, c, cp);
    d1 = pbwsf__dot(ab, ap), d2 = pbwsf__dot(ac, ap);
    d3 = pbwsf__dot(ab, bp), d4 = pbwsf__dot(ac, bp);
    d5 = pbwsf__dot(ab, cp), d6 = pbwsf__dot(ac, cp);
    vc = d1 * d4 - d3 * d2;
    vb = d5 * d2 - d1 * d6;
    va = d3 * d6 - d5 * d4;
    sum = va + vb + vc;
    if (d1 <= 0 && d2 <= 0) {
        memcpy(out, a, 3 * sizeof *out);
    } else if (d3 >= 0 && d4 <= d3) {
        memcpy(out, b, 3 * sizeof *out);
    } else if (d6 >= 0 && d5 <= d6) {
        memcpy(out, c, 3 * sizeof *out);
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        pbwsf__between(a, b, d1 / (d1 - d3), out);
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        pbwsf__between(a, c, d2 / (d2 - d6), out);
    } else if (va <= 0 && d4 >= d3 && d5 >= d6) {
        pbwsf__between(b, c, (d4 - d3) / ((d4 - d3) + (d5 - d6)), out);
    } else {
        for (k = 0; k < 3; k++) {
            out[k] = sum > 0 ? a[k] + vb / sum * ab[k] + vc / sum * ac[k] : a[k];
        }
    }
}

/* Squared. */
static double pbwsf__box_distance(const pbwsf__box *box, const double *p)
{
    double sum = 0;
    int k;
    for (k = 0; k < 3; k++) {
        const double under = box->low[k] - p[k], over = p[k] - box->high[k], out = under > over ? under : over;
        const double d = out > 0 ? out : 0;
        sum += d * d;
    }
    return sum;
}

PBWSURFACEDEF pbw_index pbw_surface_closest(const pbw_surface *surface, const double p[3], double limit,
                                            double place[3])
{
    const pbwsf__tree *tree = (const pbwsf__tree *)surface->memory;
    const pbwsf__box *box = tree->boxes.at;
    const pbw_index *order = tree->order.at;
    struct { size_t node; double distance; } stack[PBWSF__DEPTH];
    double best = limit * limit;
    pbw_index found = PBW_NONE;
    int depth = 1;
    stack[0].node = 0;
    stack[0].distance = pbwsf__box_distance(box, p);
    while (depth > 0) {
        size_t i = stack[--depth].node, k;
        if (!(stack[depth].distance < best)) {
            continue;
        }
        if (i < tree->first_leaf) {                          /* the nearer child is taken first */
            const double left = pbwsf__box_distance(box + 2 * i + 1, p);
            const double right = pbwsf__box_distance(box + 2 * i + 2, p);
            const int near_last = right < left;
            stack[depth].node = near_last ? 2 * i + 1 : 2 * i + 2;
            stack[depth++].distance = near_last ? left : right;
            stack[depth].node = near_last ? 2 * i + 2 : 2 * i + 1;
            stack[depth++].distance = near_last ? right : left;
            continue;
        }
        for (k = pbwsf__first_of(tree, i); k < pbwsf__end_of(surface, tree, i); k++) {
            double q[3], d[3];
            pbwsf__nearest_in(pbwsf__corner(surface, order[k], 0), pbwsf__corner(surface, order[k], 1),
                              pbwsf__corner(surface, order[k], 2), p, q);
            pbwsf__minus(q, p, d);
            if (pbwsf__dot(d, d) < best || (pbwsf__dot(d, d) <= best && order[k] < found && found != PBW_NONE)) {
                best = pbwsf__dot(d, d);
                found = order[k];
                memcpy(place, q, 3 * sizeof *place);
            }
        }
    }
    return found;
}

/* Returns where the segment a + t d, 0 <= t <= most, meets the box, or a smaller t; HUGE_VAL if it does not.  per[k]:
   1 / d[k]; 0 if d[k] is tiny, and 1e100 if it is zero, when a is between the sides or no point is. */
static double pbwsf__box_meets(const pbwsf__box *box, const double *a, const double *per, double most)
{
    double from = 0, to = most;
    int k;
    for (k = 0; k < 3; k++) {
        const double x = (box->low[k] - a[k]) * per[k], y = (box->high[k] - a[k]) * per[k];
        const double slack = 1e-14 * (fabs(x) + fabs(y));
        const double enter = (x < y ? x : y) - slack, leave = (x < y ? y : x) + slack;
        from = enter > from ? enter : from;
        to = leave < to ? leave : to;
    }
    return from <= to && box->low[0] <= box->high[0] ? from : HUGE_VAL;
}

/* The crossing of a segment with a triangle, by exact signs; HUGE_VAL: none.  Touching counts. */
static double pbwsf__crossing(const double *const c[3], const double *a, const double *b)
{
    const int above = pbw_orient3(c[0], c[1], c[2], a), below = pbw_orient3(c[0], c[1], c[2], b);
    double n[3], u[3], v[3], height, depth;
    int i, sign[3];
    if (above * below > 0 || (above == 0 && below == 0)) {
        return HUGE_VAL;
    }
    for (i = 0; i < 3; i++) {
        sign[i] = pbw_orient3(a, b, c[i], c[(i + 1) % 3]);
    }
    if ((sign[0] > 0 || sign[1] > 0 || sign[2] > 0) && (sign[0] < 0 || sign[1] < 0 || sign[2] < 0)) {
        return HUGE_VAL;
    }
    pbwsf__normal(c[0], c[1], c[2], n);
    pbwsf__minus(a, c[0], u);
    pbwsf__minus(b, c[0], v);
    height = fabs(pbwsf__dot(n, u));
    depth = fabs(pbwsf__dot(n, v));
    return height + depth > 0 ? height / (height + depth) : 0.5;
}

PBWSURFACEDEF pbw_index pbw_surface_meets(const pbw_surface *surface, const double a[3], const double b[3],
                                          double *where)
{
    const pbwsf__tree *tree = (const pbwsf__tree *)surface->memory;
    const pbwsf__box *box = tree->boxes.at;
    const pbw_index *order = tree->order.at;
    struct { size_t node; double from; } stack[PBWSF__DEPTH];
    double per[3], best = 1;
    pbw_index found = PBW_NONE;
    size_t k;
    int depth = 1;
    for (k = 0; k < 3; k++) {
        const double d = b[k] - a[k];
        per[k] = fabs(d) > 1e-100 ? 1 / d : fabs(d) > 0 ? 0 : 1e100;
    }
    stack[0].node = 0;
    stack[0].from = pbwsf__box_meets(box, a, per, best);
    while (depth > 0) {
        const size_t i = stack[--depth].node;
        if (stack[depth].from > best) {
            continue;
        }
        if (i < tree->first_leaf) {                          /* the nearer child is taken first */
            const double left = pbwsf__box_meets(box + 2 * i + 1, a, per, best);
            const double right = pbwsf__box_meets(box + 2 * i + 2, a, per, best);
            const size_t turned = left > right;
            const double later = turned ? left : right;
            if (later <= best) {
                stack[depth].node = 2 * i + 2 - turned;
                stack[depth++].from = later;
            }
            if ((turned ? right : left) <= best) {
                stack[depth].node = 2 * i + 1 + turned;
                stack[depth++].from = turned ? right : left;
            }
            continue;
        }
        for (k = pbwsf__first_of(tree, i); k < pbwsf__end_of(surface, tree, i); k++) {
            const double *c[3];
            double t;
            c[0] = pbwsf__corner(surface, order[k], 0);
            c[1] = pbwsf__corner(surface, order[k], 1);
            c[2] = pbwsf__corner(surface, order[k], 2);
            t = pbwsf__crossing(c, a, b);
            if (t < best || (t <= best && (found == PBW_NONE || order[k] < found))) {
                best = t;
                found = order[k];
            }
        }
    }
    *where = best;
    return found;
}

/* A walk over the leaves that have boxes in common with one: begin it, then call pbwsf__next_leaf. */
typedef struct pbwsf__walk {
    const pbw_surface *surface;
    double low[3], high[3];
    size_t stack[PBWSF__DEPTH], from, to;  /* order[from] .. order[to - 1] are the leaf's triangles */
    int depth;
} pbwsf__walk;

/* Goes to the next leaf.  Returns 0 if there is none. */
static int pbwsf__next_leaf(pbwsf__walk *walk)
{
    const pbwsf__tree *tree = (const pbwsf__tree *)walk->surface->memory;
    const pbwsf__box *box = tree->boxes.at;
    while (walk->depth > 0) {
        const size_t i = walk->stack[--walk->depth];
        int j;
        for (j = 0; j < 3 && walk->low[j] <= box[i].high[j] && walk->high[j] >= box[i].low[j]; j++) {
        }
        if (j == 3 && i < tree->first_leaf) {
            walk->stack[walk->depth++] = 2 * i + 1;
            walk->stack[walk->depth++] = 2 * i + 2;
        } else if (j == 3) {
            walk->from = pbwsf__first_of(tree, i);
            walk->to = pbwsf__end_of(walk->surface, tree, i);
            return 1;
        }
    }
    return 0;
}

/* Calls met for each triangle that the segment from a to b meets, touching included, until it returns 1. */
PBWSF__SHARED static void pbwsf__all_met(const pbw_surface *surface, const double a[3], const double b[3],
                           int (*met)(void *user, pbw_index triangle), void *user)
{
    const pbw_index *order = ((const pbwsf__tree *)surface->memory)->order.at;
    pbwsf__walk walk;
    size_t k;
    int j;
    for (j = 0; j < 3; j++) {
        walk.low[j] = a[j] < b[j] ? a[j] : b[j];
        walk.high[j] = a[j] < b[j] ? b[j] : a[j];
    }
    walk.surface = surface;
    walk.stack[0] = 0;
    walk.depth = 1;
    while (pbwsf__next_leaf(&walk)) {
        for (k = walk.from; k < walk.to; k++) {
            const double *const c[3] = { pbwsf__corner(surface, order[k], 0), pbwsf__corner(surface, order[k], 1),
                                         pbwsf__corner(surface, order[k], 2) };
            if (pbwsf__crossing(c, a, b) <= 1 && met(user, order[k])) {
                return;
            }
        }
    }
}

/* The side of p to the line through a and b, seen along z, with p raised by (e, e^2): on the line, it is that of the
   first derivative that is not zero.  Zero only if a and b are at one place.  Changes sign with the edge's direction,
   so that of two triangles at an edge exactly one has a ray through it. */
static int pbwsf__side(const double *a, const double *b, const double *p)
{
    const int sign = pbw_orient2(a, b, p);
    return sign != 0 ? sign : b[1] > a[1] ? -1 : b[1] < a[1] ? 1 : (b[0] > a[0]) - (b[0] < a[0]);
}

/* 1 if the ray from p along +z crosses the triangle out of its front, -1 if out of its back, 0 if it misses. */
static int pbwsf__is_below(const pbw_surface *s, pbw_index triangle, const double *p)
{
    const double *a = pbwsf__corner(s, triangle, 0), *b = pbwsf__corner(s, triangle, 1);
    const double *c = pbwsf__corner(s, triangle, 2);
    int first;
    if ((p[0] < a[0] && p[0] < b[0] && p[0] < c[0]) || (p[0] > a[0] && p[0] > b[0] && p[0] > c[0])
        || (p[1] < a[1] && p[1] < b[1] && p[1] < c[1]) || (p[1] > a[1] && p[1] > b[1] && p[1] > c[1])) {
        return 0;
    }
    first = pbwsf__side(a, b, p);
    return first != 0 && first == pbwsf__side(b, c, p) && first == pbwsf__side(c, a, p)
        && pbw_orient3(a, b, c, p) == -first ? first : 0;
}

/* Calls met for each triangle that the ray from p along +z crosses, with the result of pbwsf__is_below. */
static void pbwsf__ray(const pbw_surface *surface, const double p[3],
                       void (*met)(void *user, pbw_index triangle, int front), void *user)
{
    const pbw_index *order = ((const pbwsf__tree *)surface->memory)->order.at;
    pbwsf__walk walk;
    size_t k;
    memcpy(walk.low, p, sizeof walk.low);
    memcpy(walk.high, p, sizeof walk.high);
    walk.high[2] = HUGE_VAL;
    walk.surface = surface;
    walk.stack[0] = 0;
    walk.depth = 1;
    while (pbwsf__next_leaf(&walk)) {
        for (k = walk.from; k < walk.to; k++) {
            const int front = pbwsf__is_below(surface, order[k], p);
            if (front != 0) {
                met(user, order[k], front);
            }
        }
    }
}

static void pbwsf__count_fronts(void *user, pbw_index triangle, int front)
{
    (void)triangle;
    *(long *)user += front;
}

PBWSURFACEDEF long pbw_surface_turns(const pbw_surface *surface, const double p[3])
{
    long turns = 0;
    pbwsf__ray(surface, p, pbwsf__count_fronts, &turns);
    return turns;
}

PBWSURFACEDEF int pbw_surface_inside(const pbw_surface *surface, const double p[3])
{
    return (int)(pbw_surface_turns(surface, p) & 1);
}

/* The solid angle of a triangle by 4 pi (van Oosterom and Strackee 1983, "The solid angle of a plane triangle"). */
static double pbwsf__angle(const pbw_surface *s, pbw_index triangle, const double *p)
{
    double a[3], b[3], c[3], n[3], la, lb, lc;
    pbwsf__minus(pbwsf__corner(s, triangle, 0), p, a);
    pbwsf__minus(pbwsf__corner(s, triangle, 1), p, b);
    pbwsf__minus(pbwsf__corner(s, triangle, 2), p, c);
    la = sqrt(pbwsf__dot(a, a)), lb = sqrt(pbwsf__dot(b, b)), lc = sqrt(pbwsf__dot(c, c));
    pbwsf__cross(b, c, n);
    return atan2(pbwsf__dot(a, n), la * lb * lc + pbwsf__dot(a, b) * lc + pbwsf__dot(b, c) * la
                 + pbwsf__dot(c, a) * lb) / 6.283185307179586;
}

PBWSURFACEDEF double pbw_surface_winding(const pbw_surface *surface, const double p[3])
{
    const pbwsf__tree *tree = (const pbwsf__tree *)surface->memory;
    const pbwsf__box *box = tree->boxes.at;
    const pbw_index *order = tree->order.at;
    size_t stack[PBWSF__DEPTH], k;
    double sum = 0;
    int depth = 1;
    stack[0] = 0;
    while (depth > 0) {
        const size_t i = stack[--depth];
        double middle[3], d[3], far, half;
        if (box[i].low[0] > box[i].high[0]) {
            continue;
        }
        pbwsf__between(box[i].low, box[i].high, 0.5, middle);
        half = pbwsf__distance(box[i].low, middle);
        pbwsf__minus(middle, p, d);
        far = sqrt(pbwsf__dot(d, d));
        if (far > 3 * half) {
            sum += pbwsf__dot(box[i].area, d) / (12.566370614359172 * far * far * far);
        } else if (i < tree->first_leaf) {
            stack[depth++] = 2 * i + 1;
            stack[depth++] = 2 * i + 2;
        } else {
            for (k = pbwsf__first_of(tree, i); k < pbwsf__end_of(surface, tree, i); k++) {
                sum += pbwsf__angle(surface, order[k], p);
            }
        }
    }
    return sum;
}

/* ------------------------------------------------------------------------------------------------------
   >>seam         What pbw_improve.h, pbw_mesh3.h, pbw_adapt3.h and pbw_stuffing.h use of the rooms above.
   Holds: the list is what they use, tests/seam.sh compares; whoever changes what a name in it means, raises it.

   They are compiled behind this header, in one source file, and refuse another number.

     PBWSF__SHARED      improve                        interface
     pbwsf__counts      improve mesh3                  arrays
     pbwsf__flags       improve mesh3                  arrays
     pbwsf__indices     improve mesh3                  arrays
     pbwsf__numbers     improve mesh3                  arrays
     pbwsf__pair        mesh3                          arrays
     pbwsf__pairs       improve mesh3                  arrays
     pbwsf__quadruples  improve mesh3                  arrays
     pbwsf__triple      mesh3                          arrays
     pbwsf__triples     mesh3                          arrays
     pbwsf__vector      mesh3                          arrays
     pbwsf__vectors     improve mesh3                  arrays
     pbwsf__between     improve mesh3                  vectors
     pbwsf__cross       improve mesh3                  vectors
     pbwsf__distance    adapt3 improve mesh3 stuffing  vectors
     pbwsf__dot         improve mesh3                  vectors
     pbwsf__minus       improve mesh3                  vectors
     pbwsf__normal      improve mesh3                  vectors
     pbwsf__bytes       adapt3 improve mesh3           tree
     pbwsf__corner      mesh3                          tree
     pbwsf__normal_of   mesh3                          tree
     pbwsf__all_met     mesh3                          queries
     pbwsf__nearest_in  mesh3                          queries
     pbwsf__ray         mesh3                          queries
   ------------------------------------------------------------------------------------------------------ */
#define PBWSF__SEAM 1

PBW_CONTRACTION_ON
#endif /* PBW_SURFACE_IMPLEMENTATION */
