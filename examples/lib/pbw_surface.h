/* pbw_surface.h - v0.2.0 - nearest points, faults and the inside of a triangulated surface - MIT-0

   QUICK START
   In one source file, define PBW_SURFACE_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file.

       pbw_surface surface = {0};
       double place[3];
       pbw_surface_create(points, point_count, triangles, triangle_count, NULL, &surface);
       pbw_surface_closest(&surface, p, HUGE_VAL, place);            // the nearest point of the surface
       pbw_surface_inside(&surface, p);                              // 1: p is inside of a closed surface
       pbw_surface_free(&surface);

       pbw_surface_faults faults = {0};
       pbw_surface_crossings(points, point_count, triangles, triangle_count, NULL, &faults);
       // triangles faults.crossings[0] and [1] meet, from faults.segments[0..2] to [3..5]
       pbw_surface_faults_free(&faults);

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>arrays       types of growing arrays
     >>vectors      vectors and triangles in space
     >>tree         boxes over the triangles
     >>queries      nearest places, crossings, the inside
     >>welding      corners by place, edges, triangles given twice
     >>crossings    triangles that meet where they may not
     >>faults       all that is wrong with a surface
     >>seam         private names that other headers use

   FUNCTIONS
     pbw_surface_create   a tree over triangles
     pbw_surface_closest  the nearest place of the surface
     pbw_surface_meets    the first triangle that a segment meets
     pbw_surface_inside   whether a point is inside
     pbw_surface_turns    how many shells are around a point, exactly
     pbw_surface_winding  the winding number, of open surfaces too
     pbw_surface_free     frees the tree
     pbw_surface_crossings    what is wrong with a surface: triangles that meet, and other faults
     pbw_surface_faults_free  frees what it found

   HOW
   Boxes in a binary tree over the triangles in the order of a Hilbert curve: leaves of four triangles, all levels
   complete, so that no links are needed.  Queries write nothing: any number of threads may run them at once on one
   surface.  pbw_mesh3.h and pbw_improve.h do so unless options.threads is 1, and call `value`, `project` and size
   callbacks from several threads at once.
   Crossings: leaves against later leaves, with boxes of rounded numbers for each triangle.  Most pairs that are left
   have a corner in common, and one count of the triangles around that corner settles all of them (>>faults).  Where
   boxes tell too little, as those of rows of needles that are parallel to no axis, nodes get boxes that are turned
   along their triangles.

   PROMISES  (tests/test_improve.c guards them)
     inside      exact for a closed surface: the parity of a ray is counted by exact signs, and a ray through edges or
                 corners is perturbed symbolically
     closest     the nearest point up to rounding
     crossings   exactly the pairs that meet, by exact signs: nearly touching is no fault.  The same lists for any
                 number of threads (tests/test_crossings.c)
     bounded     no recursion; at most 110 bytes a triangle beside the caller's arrays

   CONFIGURATION MACROS
     PBW_SURFACE_IMPLEMENTATION  in one source file: compile the implementation there
*/
#ifndef PBW_SURFACE_H
#define PBW_SURFACE_H
#ifndef PBW_H
#include "pbw.h"
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

/* Builds the tree.  Returns PBW_ERROR_ARGUMENT for ids out of range and arrays that are NULL with a count above 0,
   PBW_ERROR_NOT_FINITE, PBW_ERROR_TOO_LARGE for counts of 2^32 and more, or what pbw_order fails with; no triangles
   are fine.  For queries a surface that is {0} has no triangles, and a point with NaN is nowhere. */
PBWDEF pbw_status pbw_surface_create(const double *points, size_t point_count, const pbw_index *triangles,
                                     size_t triangle_count, const pbw_options *options, pbw_surface *surface);
/* Returns the triangle nearest to p, and in `place` its point there; PBW_NONE if none is nearer than limit. */
PBWDEF pbw_index pbw_surface_closest(const pbw_surface *surface, const double p[3], double limit, double place[3]);
/* Returns the first triangle that the segment from a to b meets, and in *where how far along, 0 to 1, rounded;
   PBW_NONE if it meets none. */
PBWDEF pbw_index pbw_surface_meets(const pbw_surface *surface, const double a[3], const double b[3], double *where);
/* Returns 1 if a ray from p crosses the surface an odd number of times, else 0; for points on the surface either. */
PBWDEF int pbw_surface_inside(const pbw_surface *surface, const double p[3]);
/* Returns how many more triangles a ray from p leaves by their fronts than by their backs: for closed shells turned
   outward, the number of shells around p, by exact signs. */
PBWDEF long pbw_surface_turns(const pbw_surface *surface, const double p[3]);
/* Returns the winding number of the surface around p: for a closed surface turned outward 1 inside and 0 outside; for
   an open one a fraction, smooth across its holes, so that above 1/2 is a fair inside.  Triangles must be oriented
   alike.  Far parts are approximated by dipoles: the error is about 0.01, and up to 0.06. */
PBWDEF double pbw_surface_winding(const pbw_surface *surface, const double p[3]);
PBWDEF void pbw_surface_free(pbw_surface *surface);   /* fine on {0}, fine twice */

/* What is wrong with a surface.  Corners are compared by place, so that triangles with points of their own, as .stl
   files have them, are one surface: two triangles may meet in whole edges and corners that both have, and nowhere
   else.  Lists ascend; they name the caller's triangles and points, of several points at one place the first. */
typedef struct pbw_surface_faults {        /* start from {0}; pbw_surface_faults_free when done */
    size_t crossing_count;                 /* pairs of triangles that meet elsewhere; not of those of the two lists
                                              below */
    const pbw_index *crossings;            /* 2 a pair, the lower one first */
    const double *segments;                /* 6 a pair: what the two have in common, from one point to another, or the
                                              same twice, rounded; of two in one plane the ends of a longest part */
    size_t flat_count;
    const pbw_index *flat;                 /* triangles without area */
    size_t duplicate_count;
    const pbw_index *duplicates;           /* 2 each: a triangle, and the first one with the same corners */
    size_t edge_count;                     /* edges without exactly two triangles, one each way round */
    const pbw_index *edges;                /* 2 points each, the lower one first */
    const pbw_index *edge_triangles;       /* how many triangles each has: 1, open; 2, turned alike; or more */
    size_t repeated_count;                 /* no fault here, but other programs may take it for one */
    const pbw_index *repeated;             /* 2 each: a point, and the first one at its place */
    void *memory;                          /* private */
} pbw_surface_faults;

/* Finds them.  Returns what pbw_surface_create returns, PBW_CANCELLED, or PBW_ERROR_TOO_LARGE for more than 2^32 / 3
   triangles; faults are empty then.  Progress is PBW_STAGE_WORK.  Holds up to 170 bytes a triangle meanwhile, or 90 a
   point where that is more. */
PBWDEF pbw_status pbw_surface_crossings(const double *points, size_t point_count, const pbw_index *triangles,
                                        size_t triangle_count, const pbw_options *options,
                                        pbw_surface_faults *faults);
PBWDEF void pbw_surface_faults_free(pbw_surface_faults *faults);      /* fine on {0}, fine twice */

#ifdef __cplusplus
}
#endif
#endif /* PBW_SURFACE_H */

#if defined(PBW_SURFACE_IMPLEMENTATION) && !defined(PBWSURFACE__IMPLEMENTED)
#define PBWSURFACE__IMPLEMENTED

#include <float.h>
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
    pbwsf__pairs open;                     /* its open edges, from pbwsf__find_open */
    int has_open;                          /* 1: they are listed */
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

typedef struct pbwsf__building {
    const pbw_surface *surface;
    pbwsf__tree *tree;
    double *middle;                        /* of each triangle */
    size_t first;                          /* node of a level */
} pbwsf__building;

/* Makes the boxes of a range of nodes, all of one level; those of the next level below are made. */
static pbw_status pbwsf__box_range(void *arg, size_t from, size_t to)
{
    const pbwsf__building *b = (const pbwsf__building *)arg;
    const pbw_surface *s = b->surface;
    const pbwsf__tree *tree = b->tree;
    pbwsf__box *box = tree->boxes.at;
    const pbw_index *order = tree->order.at;
    size_t i, k;
    for (i = b->first + from; i < b->first + to; i++) {
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
    return PBW_OK;
}

static pbw_status pbwsf__middle_range(void *arg, size_t from, size_t to)
{
    const pbwsf__building *b = (const pbwsf__building *)arg;
    const pbw_surface *s = b->surface;
    size_t i, k;
    for (i = from; i < to; i++) {
        const pbw_index *c = s->triangles + 3 * i;
        for (k = 0; k < 3; k++) {
            b->middle[3 * i + k] = s->points[3 * (size_t)c[0] + k] / 3 + s->points[3 * (size_t)c[1] + k] / 3
                                 + s->points[3 * (size_t)c[2] + k] / 3;
        }
    }
    return PBW_OK;
}

/* The order along a Hilbert curve through the triangles' centroids. */
static pbw_status pbwsf__sort(pbwsf__building *b, pbw_options *options)
{
    const size_t count = b->surface->triangle_count;
    pbwsf__tree *tree = b->tree;
    pbwsf__numbers middle = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    if (PBW_FIT(&tree->memory, tree->order, count + 1) && PBW_FIT(&tree->memory, middle, 3 * (count + 1))) {
        b->middle = middle.at;
        options->memory_limit = pbw_memory_left(&tree->memory);
        status = pbw_for(options, count, 4096, pbwsf__middle_range, b);
        status = status != PBW_OK ? status : pbw_order(3, middle.at, count, options, tree->order.at);
        status = status == PBW_DEGENERATE ? PBW_OK : status;
    }
    PBW_RELEASE(&tree->memory, middle);
    return status;
}

static pbw_status pbwsf__build(const pbw_options *options, pbw_surface *surface)
{
    pbwsf__tree *tree = (pbwsf__tree *)surface->memory;
    pbwsf__building b = { surface, tree, NULL, 0 };
    pbw_options own;
    pbw_status status;
    size_t leaves = 1;
    memset(&own, 0, sizeof own);
    if (options != NULL) {
        own.threads = options->threads;
        own.resize = options->resize;
        own.resize_user = options->resize_user;
        own.run = options->run;
        own.run_user = options->run_user;
    }
    while (leaves * PBWSF__LEAF < surface->triangle_count) {
        leaves *= 2;
    }
    tree->first_leaf = leaves - 1;
    tree->nodes = 2 * leaves - 1;
    status = pbwsf__sort(&b, &own);
    if (status == PBW_OK && !PBW_FIT(&tree->memory, tree->boxes, tree->nodes)) {
        status = PBW_ERROR_MEMORY;
    }
    own.memory_limit = pbw_memory_left(&tree->memory);
    for (; status == PBW_OK && leaves > 0; leaves /= 2) {        /* levels, that of the leaves first */
        b.first = leaves - 1;
        status = pbw_for(&own, leaves, 2048, pbwsf__box_range, &b);
    }
    return status;
}

typedef struct pbwsf__arrays {
    const double *points;
    const pbw_index *triangles;
    size_t point_count;
} pbwsf__arrays;

static pbw_status pbwsf__check_triangles(void *arg, size_t from, size_t to)
{
    const pbwsf__arrays *a = (const pbwsf__arrays *)arg;
    for (; from < to; from++) {
        const pbw_index *c = a->triangles + 3 * from;
        if (c[0] >= a->point_count || c[1] >= a->point_count || c[2] >= a->point_count) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    return PBW_OK;
}

static pbw_status pbwsf__check_points(void *arg, size_t from, size_t to)
{
    const double *p = ((const pbwsf__arrays *)arg)->points;
    for (from *= 3, to *= 3; from < to; from++) {
        if (!(fabs(p[from]) <= 1e300)) {
            return PBW_ERROR_NOT_FINITE;
        }
    }
    return PBW_OK;
}

/* Returns PBW_OK if ids are in range and coordinates finite. */
static pbw_status pbwsf__check_input(const double *points, size_t point_count, const pbw_index *triangles,
                                     size_t triangle_count, const pbw_options *options)
{
    pbwsf__arrays arrays = { points, triangles, point_count };
    pbw_options own;
    pbw_status status;
    if ((point_count > 0 && points == NULL) || (triangle_count > 0 && triangles == NULL)) {
        return PBW_ERROR_ARGUMENT;
    }
    if (point_count > PBW_NONE || triangle_count > PBW_NONE) {
        return PBW_ERROR_TOO_LARGE;
    }
    memset(&own, 0, sizeof own);
    if (options != NULL) {
        own = *options;
        own.progress = NULL;
    }
    status = pbw_for(&own, triangle_count, 16384, pbwsf__check_triangles, &arrays);
    return status != PBW_OK ? status : pbw_for(&own, point_count, 16384, pbwsf__check_points, &arrays);
}

PBWDEF pbw_status pbw_surface_create(const double *points, size_t point_count, const pbw_index *triangles,
                                     size_t triangle_count, const pbw_options *options, pbw_surface *surface)
{
    pbw_memory memory;
    pbwsf__tree *tree;
    pbw_status status;
    if (surface == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(surface, 0, sizeof *surface);
    status = pbwsf__check_input(points, point_count, triangles, triangle_count, options);
    if (status != PBW_OK) {
        return status;
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

PBWDEF void pbw_surface_free(pbw_surface *surface)
{
    if (surface != NULL && surface->memory != NULL) {
        pbwsf__tree *tree = (pbwsf__tree *)surface->memory;
        pbw_memory memory = tree->memory;
        PBW_RELEASE(&memory, tree->order);
        PBW_RELEASE(&memory, tree->boxes);
        PBW_RELEASE(&memory, tree->open);
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
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) {     /* a and b are not at one place */
        pbwsf__between(a, b, d1 / (d1 - d3), out);
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) {
        pbwsf__between(a, c, d2 / (d2 - d6), out);
    } else if (va <= 0 && d4 >= d3 && d5 >= d6 && (d4 - d3) + (d5 - d6) > 0) {
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

/* Returns what a triangle's distance from p, squared, is not below: that of its box. */
static double pbwsf__least_distance(const double *a, const double *b, const double *c, const double *p)
{
    double sum = 0;
    int k;
    for (k = 0; k < 3; k++) {
        const double low = a[k] < b[k] ? a[k] : b[k], high = a[k] < b[k] ? b[k] : a[k];
        const double under = (low < c[k] ? low : c[k]) - p[k], over = p[k] - (high > c[k] ? high : c[k]);
        const double out = under > over ? under : over, d = out > 0 ? out : 0;
        sum += d * d;
    }
    return sum;
}

/* As pbw_surface_closest, but a triangle nearer than `enough` ends the search. */
static pbw_index pbwsf__closest(const pbw_surface *surface, const double p[3], double limit, double enough,
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
        double nearby = stack[depth].distance;
        while (i < tree->first_leaf && nearby < best) {      /* to the nearer child; the other one must wait */
            const double left = pbwsf__box_distance(box + 2 * i + 1, p);
            const double right = pbwsf__box_distance(box + 2 * i + 2, p);
            const size_t turned = right < left;
            const double away = turned ? left : right;
            if (away < best) {
                stack[depth].node = 2 * i + 2 - turned;
                stack[depth++].distance = away;
            }
            nearby = turned ? right : left;
            i = 2 * i + 1 + turned;
        }
        for (k = pbwsf__first_of(tree, i); nearby < best && k < pbwsf__end_of(surface, tree, i); k++) {
            const double *a = pbwsf__corner(surface, order[k], 0), *b = pbwsf__corner(surface, order[k], 1);
            const double *c = pbwsf__corner(surface, order[k], 2);
            double q[3], d[3];
            if (pbwsf__least_distance(a, b, c, p) > best) {
                continue;
            }
            pbwsf__nearest_in(a, b, c, p, q);
            pbwsf__minus(q, p, d);
            if (pbwsf__dot(d, d) < best || (pbwsf__dot(d, d) <= best && order[k] < found && found != PBW_NONE)) {
                best = pbwsf__dot(d, d);
                found = order[k];
                memcpy(place, q, 3 * sizeof *place);
            }
        }
        depth = best < enough * enough ? 0 : depth;
    }
    return found;
}

/* Whether a query has something to find. */
static int pbwsf__has_place(const pbw_surface *surface, const double p[3])
{
    return surface != NULL && surface->memory != NULL && p[0] <= HUGE_VAL && p[1] <= HUGE_VAL && p[2] <= HUGE_VAL;
}

PBWDEF pbw_index pbw_surface_closest(const pbw_surface *surface, const double p[3], double limit, double place[3])
{
    return limit > 0 && pbwsf__has_place(surface, p) ? pbwsf__closest(surface, p, limit, 0, place) : PBW_NONE;
}

/* Returns whether the surface is nearer to p than a distance. */
PBWSF__SHARED static int pbwsf__is_near(const pbw_surface *surface, const double p[3], double distance)
{
    double place[3];
    return pbwsf__closest(surface, p, distance, distance, place) != PBW_NONE;
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

PBWDEF pbw_index pbw_surface_meets(const pbw_surface *surface, const double a[3], const double b[3], double *where)
{
    const pbwsf__tree *tree;
    const pbwsf__box *box;
    const pbw_index *order;
    struct { size_t node; double from; } stack[PBWSF__DEPTH];
    double per[3], best = 1;
    pbw_index found = PBW_NONE;
    size_t k;
    int depth = 1;
    if (!pbwsf__has_place(surface, a) || !pbwsf__has_place(surface, b)) {
        return PBW_NONE;
    }
    tree = (const pbwsf__tree *)surface->memory;
    box = tree->boxes.at;
    order = tree->order.at;
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

PBWDEF long pbw_surface_turns(const pbw_surface *surface, const double p[3])
{
    long turns = 0;
    if (pbwsf__has_place(surface, p)) {
        pbwsf__ray(surface, p, pbwsf__count_fronts, &turns);
    }
    return turns;
}

PBWDEF int pbw_surface_inside(const pbw_surface *surface, const double p[3])
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

enum { PBWSF__OPEN = 512 };                /* so many edges take about as long as dipoles do on scans */

/* Lists the open edges, unless they are more than PBWSF__OPEN: those that more triangles have one way round than the
   other, once for each triangle more.  Winding numbers then take one ray and a sum over these edges, and are exact
   but for rounding. */
PBWSF__SHARED static pbw_status pbwsf__find_open(pbw_surface *surface, const pbw_options *options)
{
    pbwsf__tree *tree = (pbwsf__tree *)surface->memory;
    const size_t sides = 3 * surface->triangle_count;
    const pbw_index *c = surface->triangles;
    PBW_ARRAY(uint64_t) keys = { NULL, 0, 0 };
    pbwsf__indices order = { NULL, 0, 0 };
    pbw_options own = *options;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, k;
    if (surface->triangle_count >= PBW_NONE / 3) {   /* more sides than indices */
        return PBW_OK;
    }
    if (PBW_FIT(&tree->memory, keys, sides + 1) && PBW_FIT(&tree->memory, order, sides + 1)
        && PBW_FIT(&tree->memory, tree->open, PBWSF__OPEN)) {
        for (i = 0; i < sides; i++) {
            const pbw_index a = c[i], b = c[i % 3 == 2 ? i - 2 : i + 1];
            keys.at[i] = (uint64_t)(a < b ? a : b) << 32 | (a < b ? b : a);
        }
        own.memory_limit = pbw_memory_left(&tree->memory);
        status = pbw_sort(keys.at, sides, &own, order.at);
    }
    tree->has_open = status == PBW_OK;
    for (i = 0; i < sides && tree->has_open; ) {
        const uint64_t key = keys.at[order.at[i]];
        const pbw_index low = (pbw_index)(key >> 32), high = (pbw_index)(key & 0xffffffffu);
        long more = 0;                               /* triangles with the edge from low to high, less the others */
        for (; i < sides && keys.at[order.at[i]] == key; i++) {
            more += c[order.at[i]] == low ? 1 : -1;
        }
        for (k = (size_t)labs(more); k > 0 && tree->has_open && low != high; k--) {
            tree->has_open = tree->open.count < PBWSF__OPEN;
            if (tree->has_open) {
                pbw_index *edge = tree->open.at[tree->open.count++];
                edge[more < 0] = low;
                edge[more > 0] = high;
            }
        }
    }
    PBW_RELEASE(&tree->memory, keys);
    PBW_RELEASE(&tree->memory, order);
    return status;
}

/* The direction from p to a as (u[0], u[1]) / u[2]: a place on the plane of the equator of the sphere of directions,
   seen from its top.  Straight above p, that is far towards (-e, -e^2), as p is raised in pbwsf__side. */
static void pbwsf__look_down(const double *a, const double *p, double u[3])
{
    double length, square;
    pbwsf__minus(a, p, u);
    length = sqrt(pbwsf__dot(u, u));
    square = u[0] * u[0] + u[1] * u[1];
    u[0] = fabs(u[0]) + fabs(u[1]) > 0 || u[2] <= 0 ? u[0] : -1;
    u[2] = u[2] > 0 ? square / (length + u[2]) : length - u[2];        /* alike but for rounding */
}

/* Returns the solid angle, divided by 4 pi, that p sees of a triangle: its corners are a, b, and a point infinitely
   far below p.  pbwsf__look_down gives the places A and B of a and b; then the tangent of half of the angle is
   -(A x B) / (1 + A B).  The angle jumps by a full turn where the line from a to b passes above p: the exact side
   decides on which side of it p is, as in pbw_surface_turns. */
static double pbwsf__angle_down(const double *a, const double *b, const double *p)
{
    double u[3], v[3];
    pbwsf__look_down(a, p, u);
    pbwsf__look_down(b, p, v);
    return atan2(-pbwsf__side(a, b, p) * fabs(u[0] * v[1] - u[1] * v[0]), pbwsf__dot(u, v)) / 6.283185307179586;
}

PBWDEF double pbw_surface_winding(const pbw_surface *surface, const double p[3])
{
    const pbwsf__tree *tree;
    const pbwsf__box *box;
    const pbw_index *order;
    size_t stack[PBWSF__DEPTH], k;
    double sum = 0;
    int depth = 1;
    if (!pbwsf__has_place(surface, p)) {
        return 0;
    }
    tree = (const pbwsf__tree *)surface->memory;
    box = tree->boxes.at;
    order = tree->order.at;
    if (tree->has_open) {                  /* walls below open edges close the surface; no ray upwards meets them */
        sum = (double)pbw_surface_turns(surface, p);
        for (k = 0; k < tree->open.count; k++) {
            sum += pbwsf__angle_down(surface->points + 3 * (size_t)tree->open.at[k][0],
                                    surface->points + 3 * (size_t)tree->open.at[k][1], p);
        }
        return sum;
    }
    stack[0] = 0;
    while (depth > 0) {
        const size_t i = stack[--depth];
        double middle[3], d[3], away, half;
        if (box[i].low[0] > box[i].high[0]) {
            continue;
        }
        pbwsf__between(box[i].low, box[i].high, 0.5, middle);
        half = pbwsf__distance(box[i].low, middle);
        pbwsf__minus(middle, p, d);
        away = sqrt(pbwsf__dot(d, d));
        if (away > 3 * half) {
            sum += pbwsf__dot(box[i].area, d) / (12.566370614359172 * away * away * away);
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
   >>welding      Corners by place, edges, triangles given twice.
   In: points and triangles.  Out: the faults of edges, the points that repeat a place, the triangles given twice, and
   the order of the others.
   Holds: places are numbered along a Hilbert curve through the points.  Side 3 t + k of triangle t runs from its
   corner k to the next one.  The apex of a triangle is the corner with the most triangles, of several the first.
   ------------------------------------------------------------------------------------------------------ */
typedef PBW_ARRAY(uint64_t) pbwsf__keys;

typedef struct pbwsf__found {              /* what pbw_surface_faults shows */
    pbw_memory memory;
    pbwsf__indices crossings, flat, duplicates, edges, edge_triangles, repeated;
    pbwsf__numbers segments;
} pbwsf__found;

enum { PBWSF__ALL_SIGNS = 63, PBWSF__AGAIN = 64, PBWSF__FLAT = 128 };  /* again: given before */

typedef struct pbwsf__star {               /* the triangles at a place: see pbwsf__star_range */
    unsigned char signs, up[3];
} pbwsf__star;

typedef struct pbwsf__node {
    double low[3], high[3];                /* the box of its triangles */
    pbw_index apex;                        /* the corner that all of them have; PBW_NONE: there is none */
} pbwsf__node;

typedef struct pbwsf__rod {                /* a turned box around the triangles of a node that are long and alike */
    double middle[3], along[3];            /* along: a unit vector */
    double half[3];                        /* half of its extents along and across; half[0] < 0: there is none */
} pbwsf__rod;

typedef struct pbwsf__slab {               /* of the triangles of a leaf */
    float low[3][PBWSF__LEAF], high[3][PBWSF__LEAF];
    pbw_index proven[3][PBWSF__LEAF];      /* a triangle's corners, if signs prove that no two triangles around the
                                              corner cross; else PBW_NONE */
} pbwsf__slab;

#define PBWSF__LEFT ((size_t)-1)

typedef struct pbwsf__search {
    pbw_memory *memory;
    pbwsf__found *found;
    const pbw_options *given;
    pbw_options options;                   /* for calls inside */
    double done, share;                    /* progress: of the parts before, of the part that runs */
    const double *points;
    const pbw_index *triangles;
    size_t point_count, triangle_count;
    pbwsf__indices rank, first;            /* per point: its place; per place: the first point there */
    pbwsf__vectors places;
    pbwsf__indices degree;                 /* per place: the corners there */
    pbwsf__indices corners, items;         /* of triangles in the order of the tree: their places, 3 each; numbers */
    pbwsf__indices room;
    int sides;                             /* what is sorted: 1, sides; 0, triangles */
    pbwsf__keys keys;                      /* sorted: the second place, and below it the side or triangle */
    pbwsf__indices ends;                   /* per place: where the keys end that have it as first place */
    pbwsf__flags signs;                    /* per triangle: see pbwsf__signs_of */
    PBW_ARRAY(pbwsf__star) stars;          /* per place */
    PBW_ARRAY(pbwsf__node) nodes;          /* of the tree: node i has the children 2 i + 1 and 2 i + 2 */
    PBW_ARRAY(pbwsf__node) arcs;           /* the same for the directions from the apex to the sides across */
    PBW_ARRAY(pbwsf__slab) slabs;          /* per leaf */
    PBW_ARRAY(pbwsf__rod) rods;            /* per node, once boxes alone took too many steps */
    size_t first_node, first_pairs;        /* of a level; of those of its nodes that are searched next */
    size_t first_leaf, node_count;         /* node first_leaf + j has the triangles 4 j .. 4 j + 3 of items; nodes
                                              from node_count on are not there: they would have none */
    double least;                          /* see pbwsf__side_of */
    PBW_ARRAY(pbwsf__keys) pairs;          /* per node of a level: pairs of triangles that meet elsewhere */
    pbwsf__counts steps;                   /* per node of that level: how many its search took; PBWSF__LEFT: it is to
                                              be searched */
    size_t patience;                       /* what takes more steps is left for later */
} pbwsf__search;

static int pbwsf__search_progress(void *user, pbw_stage stage, double done)
{
    const pbwsf__search *s = (const pbwsf__search *)user;
    (void)stage;
    return s->given->progress(s->given->progress_user, PBW_STAGE_WORK, fmin(1, s->done + s->share * done));
}

/* Returns the options of the next part of the work; ordered: on one thread, range after range. */
static const pbw_options *pbwsf__next_part(pbwsf__search *s, double share, int ordered)
{
    s->done += s->share;
    s->share = share;
    memset(&s->options, 0, sizeof s->options);
    if (s->given != NULL) {
        s->options = *s->given;
        s->options.flags = 0;
        s->options.stride = 0;
        s->options.backend = NULL;
        s->options.trace = NULL;
        s->options.progress = s->given->progress != NULL ? pbwsf__search_progress : NULL;
        s->options.progress_user = s;
    }
    if (ordered) {
        s->options.threads = 1;
        s->options.run = NULL;
    }
    s->options.memory_limit = pbw_memory_left(s->memory);
    return &s->options;
}

/* Calls body range after range, so that it may count and append. */
static pbw_status pbwsf__in_order(pbwsf__search *s, double share, size_t count, pbw_body *body)
{
    return pbw_for(pbwsf__next_part(s, share, 1), count, 65536, body, s);
}

static int pbwsf__same_place(const double *p, const double *q)
{
    return p[0] <= q[0] && p[0] >= q[0] && p[1] <= q[1] && p[1] >= q[1] && p[2] <= q[2] && p[2] >= q[2];
}

/* room: the order of the points. */
static pbw_status pbwsf__weld_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    for (; from < to; from++) {
        const pbw_index point = s->room.at[from];
        const double *p = s->points + 3 * (size_t)point;
        if (from == 0 || !pbwsf__same_place(p, s->places.at[s->first.count - 1])) {
            memcpy(s->places.at[s->first.count], p, sizeof *s->places.at);
            s->first.at[s->first.count++] = point;
        }
        s->rank.at[point] = (pbw_index)(s->first.count - 1);
    }
    return PBW_OK;
}

static pbw_status pbwsf__repeated_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    for (; from < to; from++) {
        const pbw_index first = s->first.at[s->rank.at[from]];
        if (first != from && (!PBW_PUSH(s->memory, s->found->repeated, (pbw_index)from)
                              || !PBW_PUSH(s->memory, s->found->repeated, first))) {
            return PBW_ERROR_MEMORY;
        }
    }
    return PBW_OK;
}

static pbw_status pbwsf__corner_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    for (; from < to; from++) {
        s->corners.at[from] = s->rank.at[s->triangles[from]];
        s->degree.at[s->corners.at[from]]++;
    }
    return PBW_OK;
}

/* Numbers the places, and fills the corners. */
static pbw_status pbwsf__weld(pbwsf__search *s)
{
    const size_t points = s->point_count, corners = 3 * s->triangle_count;
    pbw_status status = PBW_ERROR_MEMORY;
    if (PBW_FIT(s->memory, s->room, points + 1) && PBW_FIT(s->memory, s->rank, points + 1)
        && PBW_FIT(s->memory, s->first, points + 1) && PBW_FIT(s->memory, s->places, points + 1)) {
        status = pbw_order(3, s->points, points, pbwsf__next_part(s, 0.2, 0), s->room.at);
        status = status == PBW_DEGENERATE ? PBW_OK : status;
    }
    status = status != PBW_OK ? status : pbwsf__in_order(s, 0.05, points, pbwsf__weld_range);
    status = status != PBW_OK ? status : pbwsf__in_order(s, 0.02, points, pbwsf__repeated_range);
    PBW_RELEASE(s->memory, s->room);
    if (status == PBW_OK
        && (!PBW_FIT(s->memory, s->corners, corners + 1) || !PBW_FIT(s->memory, s->places, s->first.count + 1)
            || !PBW_ZEROS(s->memory, s->degree, s->first.count))) {
        status = PBW_ERROR_MEMORY;
    }
    status = status != PBW_OK ? status : pbwsf__in_order(s, 0.03, corners, pbwsf__corner_range);
    PBW_RELEASE(s->memory, s->rank);
    return status;
}

/* The places of a side, the lower one first, and across from it. */
static void pbwsf__side_places(const pbwsf__search *s, pbw_index side, pbw_index out[3])
{
    const pbw_index k = side % 3, *c = s->corners.at + (side - k);
    const pbw_index a = c[k], b = c[k == 2 ? 0 : k + 1];
    out[0] = a < b ? a : b;
    out[1] = a < b ? b : a;
    out[2] = c[k == 0 ? 2 : k - 1];
}

/* By which places an item is sorted: a side by both of its own, a triangle by its apex and the lower one of the
   others. */
static void pbwsf__places_of(const pbwsf__search *s, pbw_index item, pbw_index out[2])
{
    const pbw_index *c = s->corners.at + 3 * (size_t)item, *degree = s->degree.at;
    int k, apex = 0;
    if (s->sides) {
        pbw_index v[3];
        pbwsf__side_places(s, item, v);
        out[0] = v[0], out[1] = v[1];
        return;
    }
    for (k = 1; k < 3; k++) {
        if (degree[c[k]] > degree[c[apex]] || (degree[c[k]] == degree[c[apex]] && c[k] < c[apex])) {
            apex = k;
        }
    }
    out[0] = c[apex];
    out[1] = c[(apex + 1) % 3] < c[(apex + 2) % 3] ? c[(apex + 1) % 3] : c[(apex + 2) % 3];
}

static pbw_status pbwsf__count_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    pbw_index v[2];
    for (; from < to; from++) {
        pbwsf__places_of(s, (pbw_index)from, v);
        s->ends.at[v[0]]++;
    }
    return PBW_OK;
}

/* ends: where the keys of each place begin, and behind it where they end. */
static pbw_status pbwsf__place_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    pbw_index v[2];
    for (; from < to; from++) {
        pbwsf__places_of(s, (pbw_index)from, v);
        s->keys.at[s->ends.at[v[0]]++] = (uint64_t)v[1] << 32 | from;
    }
    return PBW_OK;
}

/* Sorts keys, none of which are equal. */
static pbw_status pbwsf__sort_keys(pbwsf__search *s, uint64_t *keys, size_t count)
{
    pbw_status status = PBW_ERROR_MEMORY;
    pbw_options alone = s->options;
    pbwsf__keys copy = { NULL, 0, 0 };
    pbwsf__indices order = { NULL, 0, 0 };
    size_t i, k;
    for (i = 1; i < count && count <= 64; i++) {
        const uint64_t key = keys[i];
        for (k = i; k > 0 && keys[k - 1] > key; k--) {
            keys[k] = keys[k - 1];
        }
        keys[k] = key;
    }
    if (count <= 64) {
        return PBW_OK;
    }
    alone.threads = 1;
    alone.progress = NULL;
    if (PBW_FIT(s->memory, copy, count) && PBW_FIT(s->memory, order, count)) {
        memcpy(copy.at, keys, count * sizeof *keys);
        status = pbw_sort(copy.at, count, &alone, order.at);
    }
    for (i = 0; i < count && status == PBW_OK; i++) {
        keys[i] = copy.at[order.at[i]];
    }
    PBW_RELEASE(s->memory, copy);
    PBW_RELEASE(s->memory, order);
    return status;
}

static size_t pbwsf__begin_of(const pbwsf__search *s, size_t place)
{
    return place > 0 ? s->ends.at[place - 1] : 0;
}

static pbw_status pbwsf__sort_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    pbw_status status = PBW_OK;
    for (; from < to && status == PBW_OK; from++) {
        const size_t begin = pbwsf__begin_of(s, from);
        status = pbwsf__sort_keys(s, s->keys.at + begin, s->ends.at[from] - begin);
    }
    return status;
}

/* Sorts the sides, or triangles, by two places each, those with the same places by their numbers. */
static pbw_status pbwsf__sort_items(pbwsf__search *s, int sides)
{
    const size_t count = (sides ? 3 : 1) * s->triangle_count, places = s->first.count;
    pbw_status status = PBW_FIT(s->memory, s->keys, count + 1) && PBW_ZEROS(s->memory, s->ends, places)
                      ? PBW_OK : PBW_ERROR_MEMORY;
    pbw_index begin = 0;
    size_t i;
    s->sides = sides;
    status = status != PBW_OK ? status : pbwsf__in_order(s, 0.04, count, pbwsf__count_range);
    for (i = 0; i < places && status == PBW_OK; i++) {
        const pbw_index of_place = s->ends.at[i];
        s->ends.at[i] = begin;
        begin += of_place;
    }
    status = status != PBW_OK ? status : pbwsf__in_order(s, 0.06, count, pbwsf__place_range);
    return status != PBW_OK ? status : pbw_for(pbwsf__next_part(s, 0.03, 0), places, 4096, pbwsf__sort_range, s);
}

static pbw_status pbwsf__gather_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    for (; from < to; from++) {
        s->items.at[from] = (pbw_index)s->keys.at[from];
        memcpy(s->room.at + 3 * from, s->corners.at + 3 * (size_t)s->items.at[from], 3 * sizeof *s->room.at);
    }
    return PBW_OK;
}

/* Fills items, and puts the corners into their order. */
static pbw_status pbwsf__sort_triangles(pbwsf__search *s)
{
    const size_t count = s->triangle_count;
    pbw_status status = pbwsf__sort_items(s, 0);
    PBW_RELEASE(s->memory, s->degree);
    if (status == PBW_OK && (!PBW_FIT(s->memory, s->items, count + 1) || !PBW_FIT(s->memory, s->room, 3 * count + 1)
                             || !PBW_ZEROS(s->memory, s->signs, count + 1))) {
        status = PBW_ERROR_MEMORY;
    }
    status = status != PBW_OK ? status
           : pbw_for(pbwsf__next_part(s, 0.02, 0), count, 16384, pbwsf__gather_range, s);
    PBW_RELEASE(s->memory, s->corners);
    s->corners = s->room;
    memset(&s->room, 0, sizeof s->room);
    return status;
}

/* The keys from .. end - 1 are sides of one edge, of places a < b.  Lists the edge if it is faulty; its ends have no
   star then. */
static int pbwsf__list_edge(pbwsf__search *s, pbw_index a, pbw_index b, size_t from, size_t end)
{
    pbwsf__found *f = s->found;
    const pbw_index p = s->first.at[a], q = s->first.at[b];
    size_t i, forward = 0;
    for (i = from; i < end; i++) {
        forward += s->corners.at[s->keys.at[i] & 0xffffffffu] == a;
    }
    if (end - from == 2 && forward == 1) {
        return 1;
    }
    s->stars.at[a].signs = s->stars.at[b].signs = 0;
    return PBW_PUSH(s->memory, f->edges, p < q ? p : q) && PBW_PUSH(s->memory, f->edges, p < q ? q : p)
        && PBW_PUSH(s->memory, f->edge_triangles, (pbw_index)(end - from));
}

/* Lists triangles given twice among the sides from .. end - 1 of one edge that ends at b; each triangle counts at the
   edge across from its last corner.  Like flat ones, they leave the search. */
static pbw_status pbwsf__list_triangles(pbwsf__search *s, pbw_index b, size_t from, size_t end)
{
    uint64_t *keys = s->keys.at + from;
    pbw_status status;
    size_t i, count = 0, first = 0;
    for (i = 0; i < end - from; i++) {
        const pbw_index side = (pbw_index)keys[i];
        pbw_index v[3];
        pbwsf__side_places(s, side, v);
        if (v[2] > b) {
            keys[count++] = (uint64_t)v[2] << 32 | side / 3;
        }
    }
    status = pbwsf__sort_keys(s, keys, count);
    for (i = 1; i < count && status == PBW_OK; i++) {
        const pbw_index t = (pbw_index)keys[i];
        if (keys[i] >> 32 != keys[first] >> 32) {
            first = i;
        } else if (PBW_PUSH(s->memory, s->found->duplicates, s->items.at[t])
                   && PBW_PUSH(s->memory, s->found->duplicates, s->items.at[(pbw_index)keys[first]])) {
            s->signs.at[t] = PBWSF__AGAIN;
        } else {
            status = PBW_ERROR_MEMORY;
        }
    }
    return status;
}

static pbw_status pbwsf__edge_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    pbw_status status = PBW_OK;
    for (; from < to && status == PBW_OK; from++) {
        const size_t all = s->ends.at[from];
        size_t i = pbwsf__begin_of(s, from), end;
        for (; i < all && status == PBW_OK; i = end) {
            const pbw_index b = (pbw_index)(s->keys.at[i] >> 32);
            for (end = i + 1; end < all && s->keys.at[end] >> 32 == b; end++) {
            }
            if (b == from) {                         /* no edge: both ends are at one place */
                continue;
            }
            status = !pbwsf__list_edge(s, (pbw_index)from, b, i, end) ? PBW_ERROR_MEMORY
                   : end - i > 1 ? pbwsf__list_triangles(s, b, i, end) : PBW_OK;
        }
    }
    return status;
}

/* Lists faulty edges, and triangles given twice. */
static pbw_status pbwsf__list_edges(pbwsf__search *s)
{
    pbw_status status = PBW_FIT(s->memory, s->stars, s->first.count + 1) ? pbwsf__sort_items(s, 1)
                      : PBW_ERROR_MEMORY;
    size_t i;
    for (i = 0; i < s->first.count && status == PBW_OK; i++) {
        memset(s->stars.at + i, 0, sizeof *s->stars.at);
        s->stars.at[i].signs = PBWSF__ALL_SIGNS;
    }
    status = status != PBW_OK ? status : pbwsf__in_order(s, 0.05, s->first.count, pbwsf__edge_range);
    PBW_RELEASE(s->memory, s->keys);
    PBW_RELEASE(s->memory, s->ends);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>crossings    Triangles that meet where they may not.
   In: triangles with area, no two with the same corners.  Out: pairs of them, and what they have in common.
   Two triangles meet in a convex set.  If they have a corner in common and meet elsewhere, too, that set reaches from
   the corner to the side across in one of them; if they have none, it ends at a side of one.  So it is enough to
   test these sides against the other triangle; two with two corners in common must lie in one plane, on one side.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwsf__triangle {
    const double *x[3];
    pbw_index c[3], id;                    /* places; its number */
    double low[3], high[3];
    double n[3], size[3];                  /* normal; sums of the products' absolute values in it; size[0] < 0: not
                                              computed */
} pbwsf__triangle;

/* corners: 3 places. */
static void pbwsf__load_triangle(const pbwsf__search *s, const pbw_index *corners, pbw_index id, pbwsf__triangle *t)
{
    int k, i;
    t->id = id;
    t->size[0] = -1;
    for (i = 0; i < 3; i++) {
        t->c[i] = corners[i];
        t->x[i] = s->places.at[t->c[i]];
    }
    for (k = 0; k < 3; k++) {
        const double a = t->x[0][k], b = t->x[1][k], c = t->x[2][k], low = a < b ? a : b, high = a < b ? b : a;
        t->low[k] = c < low ? c : low;
        t->high[k] = c > high ? c : high;
    }
}

/* Returns pbw_orient3 of a triangle and p.  The filter is that of Shewchuk 1997, "Adaptive Precision Floating-Point
   Arithmetic and Fast Robust Geometric Predicates", 4.3: of the determinant of three differences the rounding error
   is at most (7 + 56 2^-53) 2^-53 < 8e-16 times the sum of absolute values.  Coordinates below 1e90 overflow nowhere;
   products of two below 2^-1022 are off by 2^-1075 each, which six differences below 2e90 make at most 1e-232, so
   that s->least, 1e-230, covers it; s->least is infinite for larger coordinates. */
static int pbwsf__side_of(const pbwsf__search *s, pbwsf__triangle *t, const double *p)
{
    const double *a = t->x[0];
    double d[3], value, error;
    int k;
    for (k = 0; k < 3; k++) {                        /* a plane across an axis */
        if (t->low[k] == p[k] && t->high[k] == p[k]) {
            return 0;
        }
    }
    if (t->size[0] < 0) {
        double u[3], v[3];
        pbwsf__minus(t->x[1], a, u);
        pbwsf__minus(t->x[2], a, v);
        pbwsf__cross(u, v, t->n);
        for (k = 0; k < 3; k++) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            t->size[k] = fabs(u[i] * v[j]) + fabs(u[j] * v[i]);
        }
    }
    pbwsf__minus(p, a, d);
    value = pbwsf__dot(t->n, d);
    error = 8e-16 * (t->size[0] * fabs(d[0]) + t->size[1] * fabs(d[1]) + t->size[2] * fabs(d[2])) + s->least;
    return value > error ? 1 : value < -error ? -1 : pbw_orient3(a, t->x[1], t->x[2], p);
}

/* Returns pbw_orient2 of three points seen along an axis. */
static int pbwsf__turn(int axis, const double *a, const double *b, const double *c)
{
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    const double p[2] = { a[i], a[j] }, q[2] = { b[i], b[j] }, r[2] = { c[i], c[j] };
    const int on_line = (p[0] == q[0] && q[0] == r[0]) || (p[1] == q[1] && q[1] == r[1]);
    return on_line ? 0 : pbw_orient2(p, q, r);
}

/* Returns an axis along which the triangle has area, and its sign there; 3 if it has none. */
static int pbwsf__axis_of(const double *const x[3], int *sign)
{
    int axis = 0;
    while (axis < 3 && (*sign = pbwsf__turn(axis, x[0], x[1], x[2])) == 0) {
        axis++;
    }
    return axis;
}

/* Returns whether a segment in the plane of a triangle meets it: they are apart if both ends are beyond one side, or
   all corners are on one side of the segment; these are the sides of the polygon of differences. */
static int pbwsf__flat_meets(const double *const x[3], const double *a, const double *b)
{
    int sign, axis = pbwsf__axis_of(x, &sign), turn[3], k;
    for (k = 0; k < 3; k++) {
        const double *p = x[k], *q = x[(k + 1) % 3];
        turn[k] = pbwsf__turn(axis, a, b, p);
        if (pbwsf__turn(axis, p, q, a) * sign < 0 && pbwsf__turn(axis, p, q, b) * sign < 0) {
            return 0;
        }
    }
    return turn[0] == 0 || turn[1] != turn[0] || turn[2] != turn[0];
}

/* Returns whether a segment meets a triangle; above, below: the sides of its ends. */
static int pbwsf__segment_meets(const double *const x[3], const double *a, const double *b, int above, int below)
{
    int sign[3], k;
    if (above * below > 0) {
        return 0;
    }
    if (above == 0 && below == 0) {
        return pbwsf__flat_meets(x, a, b);
    }
    for (k = 0; k < 3; k++) {
        sign[k] = pbw_orient3(a, b, x[k], x[(k + 1) % 3]);
    }
    return !((sign[0] > 0 || sign[1] > 0 || sign[2] > 0) && (sign[0] < 0 || sign[1] < 0 || sign[2] < 0));
}

/* Returns whether the box around the side of t across from corner k is apart from the box of u. */
static int pbwsf__side_apart(const pbwsf__triangle *t, int k, const pbwsf__triangle *u)
{
    const double *a = t->x[(k + 1) % 3], *b = t->x[(k + 2) % 3];
    int i;
    for (i = 0; i < 3; i++) {
        if ((a[i] < u->low[i] && b[i] < u->low[i]) || (a[i] > u->high[i] && b[i] > u->high[i])) {
            return 1;
        }
    }
    return 0;
}

/* Fills in the sides of u's corners to the plane of t, 0 for corner `common`.  Returns whether the others are all on
   one side. */
static int pbwsf__all_beyond(const pbwsf__search *s, pbwsf__triangle *t, const pbwsf__triangle *u, int common,
                             int side[3])
{
    int k, least = 1, most = -1;
    for (k = 0; k < 3; k++) {
        side[k] = k == common ? 0 : pbwsf__side_of(s, t, u->x[k]);
        least = k != common && side[k] < least ? side[k] : least;
        most = k != common && side[k] > most ? side[k] : most;
    }
    return least > 0 || most < 0;
}

/* Returns whether a side of t meets u; of those at corner `common` only the one across.  side: of t's corners to the
   plane of u. */
static int pbwsf__sides_meet(const pbwsf__triangle *t, const int side[3], int common, const pbwsf__triangle *u)
{
    int k;
    for (k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        if ((common < 0 || k == common) && pbwsf__segment_meets(u->x, t->x[i], t->x[j], side[i], side[j])) {
            return 1;
        }
    }
    return 0;
}

/* Returns whether two triangles that share side p q, with the corners a and b across, lie on each other: one plane,
   one side of p q. */
static int pbwsf__folded(const double *p, const double *q, const double *a, const double *b)
{
    const double *x[3];
    int sign, axis;
    x[0] = p, x[1] = q, x[2] = a;
    axis = pbwsf__axis_of(x, &sign);
    return pbwsf__turn(axis, p, q, b) == sign;
}

/* Returns whether all corners of u are beyond one side of t, in the plane of both. */
static int pbwsf__beside(const pbwsf__triangle *t, const pbwsf__triangle *u)
{
    int sign, axis = pbwsf__axis_of(t->x, &sign), i, k;
    for (k = 0; k < 3; k++) {
        for (i = 0; i < 3 && pbwsf__turn(axis, t->x[k], t->x[(k + 1) % 3], u->x[i]) * sign < 0; i++) {
        }
        if (i == 3) {
            return 1;
        }
    }
    return 0;
}

/* Returns whether two triangles are apart that are on both sides of a plane across an axis: their corners on it have
   boxes that are apart. */
static int pbwsf__parted(const pbwsf__triangle *t, const pbwsf__triangle *u)
{
    int axis, k, i;
    for (axis = 0; axis < 3; axis++) {
        const int above = t->low[axis] == u->high[axis];
        const double at = above ? t->low[axis] : t->high[axis];
        if (!above && at != u->low[axis]) {
            continue;
        }
        for (k = (axis + 1) % 3; k != axis; k = (k + 1) % 3) {
            double low[2] = { HUGE_VAL, HUGE_VAL }, high[2] = { -HUGE_VAL, -HUGE_VAL };
            for (i = 0; i < 6; i++) {
                const double *x = i < 3 ? t->x[i] : u->x[i - 3];
                if (x[axis] == at) {
                    low[i / 3] = x[k] < low[i / 3] ? x[k] : low[i / 3];
                    high[i / 3] = x[k] > high[i / 3] ? x[k] : high[i / 3];
                }
            }
            if (low[0] > high[1] || low[1] > high[0]) {
                return 1;
            }
        }
    }
    return 0;
}

/* Returns whether two triangles have more in common than corners and sides.  Their boxes meet. */
static int pbwsf__meet(const pbwsf__search *s, pbwsf__triangle *t, pbwsf__triangle *u)
{
    int i, j, common = 0, in_t = -1, in_u = -1, sum_t = 0, sum_u = 0, of_t[3], of_u[3];
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            if (t->c[i] == u->c[j]) {
                common++;
                in_t = i, in_u = j;
                sum_t += i, sum_u += j;
            }
        }
    }
    if (common == 2) {                               /* 3 - sum: the corners across */
        const double *away = u->x[3 - sum_u];
        return pbwsf__side_of(s, t, away) == 0
            && pbwsf__folded(t->x[(4 - sum_t) % 3], t->x[(5 - sum_t) % 3], t->x[3 - sum_t], away);
    }
    if (common == 1 ? pbwsf__side_apart(t, in_t, u) && pbwsf__side_apart(u, in_u, t) : pbwsf__parted(t, u)) {
        return 0;
    }
    if (pbwsf__all_beyond(s, t, u, in_u, of_u)) {
        return 0;
    }
    if (common == 0 && of_u[0] == 0 && of_u[1] == 0 && of_u[2] == 0) {
        return !pbwsf__beside(t, u) && !pbwsf__beside(u, t);
    }
    return !pbwsf__all_beyond(s, u, t, in_t, of_t)
        && (pbwsf__sides_meet(t, of_t, in_t, u) || pbwsf__sides_meet(u, of_u, in_u, t));
}

static int pbwsf__boxes_meet(const double *low, const double *high, const double *other_low,
                             const double *other_high)
{
    return (low[0] <= other_high[0]) & (high[0] >= other_low[0]) & (low[1] <= other_high[1])
         & (high[1] >= other_low[1]) & (low[2] <= other_high[2]) & (high[2] >= other_low[2]);
}

/* Returns whether there is an s >= 0 so that, along each axis, s times one of the node's directions is in the box, as
   seen from the apex.  Directions have room for 5e-15 in each bound, more than products and quotients are off. */
static int pbwsf__reaches(const pbwsf__search *s, const pbwsf__node *arc, const pbwsf__node *box)
{
    const double *x = s->places.at[arc->apex];
    double least = 0, most = HUGE_VAL;
    int i;
    for (i = 0; i < 6 && least <= most; i++) {       /* s d <= bound, and the same mirrored */
        const double d = i < 3 ? arc->low[i] : -arc->high[i - 3];
        const double bound = i < 3 ? box->high[i] - x[i] : x[i - 3] - box->low[i - 3];
        if (d > 0) {
            most = bound / d < most ? bound / d : most;
        } else if (bound < 0) {
            least = d < 0 ? (bound / d > least ? bound / d : least) : HUGE_VAL;
        }
    }
    return least <= most && least < HUGE_VAL;
}

/* ---- rods: the boxes of long triangles at a slant overlap where the triangles are far apart.  Coordinates are below
   1e90 */

typedef struct pbwsf__turned { double middle[3], axes[3][3], half[3]; } pbwsf__turned;

/* Makes the axes of a rod: along it, and two across that turn little where it turns little, unless it is close to an
   odd direction.  Each component, and each product of two axes, is off by less than 1e-13.  Returns 0 if the rod is
   close to that direction. */
static int pbwsf__axes_of(const double along[3], double axes[3][3])
{
    static const double odd[3] = { 0.347, 0.503, 0.791 };
    double length;
    int k;
    memcpy(axes[0], along, sizeof axes[0]);
    pbwsf__cross(odd, along, axes[1]);
    length = sqrt(pbwsf__dot(axes[1], axes[1]));
    for (k = 0; k < 3 && length > 0.01; k++) {
        axes[1][k] /= length;
    }
    pbwsf__cross(along, axes[1], axes[2]);
    return length > 0.01;
}

/* Returns whether the node has a rod; fills in that, or its own box. */
static int pbwsf__turned_of(const pbwsf__search *s, size_t node, pbwsf__turned *out)
{
    const pbwsf__rod *rod = s->rods.at + node;
    const pbwsf__node *box = s->nodes.at + node;
    int k;
    if (rod->half[0] >= 0) {
        memcpy(out->middle, rod->middle, sizeof out->middle);
        memcpy(out->half, rod->half, sizeof out->half);
        return pbwsf__axes_of(rod->along, out->axes);
    }
    memset(out->axes, 0, sizeof out->axes);
    for (k = 0; k < 3; k++) {
        out->middle[k] = 0.5 * box->low[k] + 0.5 * box->high[k];
        out->half[k] = fmax(out->middle[k] - box->low[k], box->high[k] - out->middle[k]);
        out->axes[k][k] = 1;
    }
    return 0;
}

/* Returns half of a turned box's extent along u, or more: by 1e-12 of its size, as its axes are off by 1e-13, and
   differences and products of all that is computed with it by less. */
static double pbwsf__half_along(const pbwsf__turned *box, const double u[3])
{
    const double all = 1e-12 * (fabs(u[0]) + fabs(u[1]) + fabs(u[2]));
    return box->half[0] * (fabs(pbwsf__dot(u, box->axes[0])) + all)
         + box->half[1] * (fabs(pbwsf__dot(u, box->axes[1])) + all)
         + box->half[2] * (fabs(pbwsf__dot(u, box->axes[2])) + all);
}

/* Returns whether two turned boxes are apart along u; away: from the middle of b to that of a.  Products that matter
   are above 1e-250, so that none underflows. */
static int pbwsf__apart_along(const pbwsf__turned *a, const pbwsf__turned *b, const double away[3], const double u[3])
{
    const double slack = 1e-14 * (fabs(u[0] * away[0]) + fabs(u[1] * away[1]) + fabs(u[2] * away[2]));
    return fabs(u[0]) + fabs(u[1]) + fabs(u[2]) > 1e-120
        && fabs(pbwsf__dot(u, away)) - slack > pbwsf__half_along(a, u) + pbwsf__half_along(b, u);
}

/* Returns whether rods show that the triangles below two nodes are apart: along what is across a rod of the way from
   one to the other, or along what is across both. */
static int pbwsf__rods_apart(const pbwsf__search *s, size_t i, size_t k)
{
    pbwsf__turned turned[2];
    const int rods = pbwsf__turned_of(s, i, turned) + 2 * pbwsf__turned_of(s, k, turned + 1);
    double away[3], u[3];
    int side, axis;
    pbwsf__minus(turned[0].middle, turned[1].middle, away);
    for (side = 0; side < 2; side++) {
        const double *along = turned[side].axes[0];
        const double part = pbwsf__dot(away, along);
        for (axis = 0; axis < 3; axis++) {
            u[axis] = away[axis] - part * along[axis];
        }
        if ((rods >> side & 1) && pbwsf__apart_along(turned, turned + 1, away, u)) {
            return 1;
        }
    }
    pbwsf__cross(turned[0].axes[0], turned[1].axes[0], u);
    return rods == 3 && pbwsf__apart_along(turned, turned + 1, away, u);
}

/* Returns whether triangles below two nodes may meet elsewhere than in a corner that all of them have: then there is
   a direction from it to both. */
static int pbwsf__nodes_meet(const pbwsf__search *s, size_t i, size_t k)
{
    const pbwsf__node *a = s->nodes.at + i, *b = s->nodes.at + k, *f = s->arcs.at + i, *g = s->arcs.at + k;
    return pbwsf__boxes_meet(a->low, a->high, b->low, b->high)
        && (f->apex != g->apex || f->apex == PBW_NONE || pbwsf__boxes_meet(f->low, f->high, g->low, g->high))
        && (f->apex == PBW_NONE || pbwsf__reaches(s, f, b)) && (g->apex == PBW_NONE || pbwsf__reaches(s, g, a))
        && (s->rods.count == 0 || !pbwsf__rods_apart(s, i, k));
}

/* Tests items i and k, and keeps the pair if they meet. */
static int pbwsf__test_pair(const pbwsf__search *s, size_t i, size_t k, pbwsf__keys *pairs)
{
    pbwsf__triangle t, u;
    pbwsf__load_triangle(s, s->corners.at + 3 * i, s->items.at[i], &t);
    pbwsf__load_triangle(s, s->corners.at + 3 * k, s->items.at[k], &u);
    return !pbwsf__boxes_meet(t.low, t.high, u.low, u.high) || !pbwsf__meet(s, &t, &u)
        || PBW_PUSH(s->memory, *pairs, t.id < u.id ? (uint64_t)t.id << 32 | u.id : (uint64_t)u.id << 32 | t.id);
}

/* Tests the triangles of two leaves against each other, or of one, but for those with a proven corner in common. */
static int pbwsf__test_leaves(const pbwsf__search *s, size_t a, size_t b, pbwsf__keys *pairs)
{
    const pbwsf__slab *p = s->slabs.at + a, *q = s->slabs.at + b;
    int i, j, k, good = 1;
    for (i = 0; i < PBWSF__LEAF; i++) {
        int meets[PBWSF__LEAF], any = 0;
        for (k = 0; k < PBWSF__LEAF; k++) {
            meets[k] = (p->low[0][i] <= q->high[0][k]) & (p->high[0][i] >= q->low[0][k])
                     & (p->low[1][i] <= q->high[1][k]) & (p->high[1][i] >= q->low[1][k])
                     & (p->low[2][i] <= q->high[2][k]) & (p->high[2][i] >= q->low[2][k]);
        }
        for (j = 0; j < 3; j++) {
            const pbw_index c = p->proven[j][i];
            for (k = 0; k < PBWSF__LEAF; k++) {
                meets[k] &= (c == PBW_NONE)
                          | ((q->proven[0][k] != c) & (q->proven[1][k] != c) & (q->proven[2][k] != c));
            }
        }
        for (k = 0; k < PBWSF__LEAF; k++) {
            any |= meets[k];
        }
        for (k = a == b ? i + 1 : 0; k < PBWSF__LEAF && any; k++) {
            good = good && (!meets[k] || pbwsf__test_pair(s, PBWSF__LEAF * a + (size_t)i, PBWSF__LEAF * b + (size_t)k,
                                                          pairs));
        }
    }
    return good;
}

/* Tests the triangles below a node against each other, and against those of later leaves.  It takes pairs of nodes
   from a stack: if their boxes meet, it puts the pairs of their children there, and it tests pairs of leaves.  It
   counts its steps, and gives up if they are too many. */
static int pbwsf__test_node(const pbwsf__search *s, size_t node, pbwsf__keys *pairs, size_t *steps)
{
    size_t stack[4 * PBWSF__DEPTH][2], i, k;
    int depth = 0, good = 1;
    pairs->count = 0;
    *steps = 0;
    for (i = node; i > 0; i = (i - 1) / 2) {         /* with the nodes on the right of the way up */
        if (i % 2 == 1) {
            stack[depth][0] = node;
            stack[depth++][1] = i + 1;
        }
    }
    stack[depth][0] = stack[depth][1] = node;
    for (depth++; depth > 0 && good; ) {
        const size_t a = stack[--depth][0], b = stack[depth][1];
        if (a >= s->node_count || b >= s->node_count || (a != b && !pbwsf__nodes_meet(s, a, b))) {
            continue;
        }
        if (++*steps > s->patience) {
            *steps = PBWSF__LEFT;
            return 1;
        }
        if (a >= s->first_leaf && b >= s->first_leaf) {
            good = pbwsf__test_leaves(s, a - s->first_leaf, b - s->first_leaf, pairs);
        }
        for (i = 0; i < 2 && b < s->first_leaf; i++) {               /* a is on the level of b, or below it */
            for (k = 0; k < (b < a ? 1 : a == b ? i + 1 : 2); k++) {
                stack[depth][0] = b < a ? a : 2 * a + 1 + k;
                stack[depth++][1] = 2 * b + 1 + i;
            }
        }
    }
    return good;
}

/* ---- what two triangles have in common, in rounded arithmetic */

typedef struct pbwsf__common { double at[14][3]; int count; } pbwsf__common;

/* Adds where a side of t meets u: a point, or in one plane the ends of the part in u.  The lower end of a side is the
   first, so that it meets u in the same point as side of another triangle. */
static void pbwsf__add_common(const double *const x[3], const double *p, const double *q, pbwsf__common *out)
{
    const int turned = q[0] < p[0] || (q[0] <= p[0] && (q[1] < p[1] || (q[1] <= p[1] && q[2] < p[2])));
    const double *a = turned ? q : p, *b = turned ? p : q;
    const int above = pbw_orient3(x[0], x[1], x[2], a), below = pbw_orient3(x[0], x[1], x[2], b);
    double n[3], from = 0, to = 1;
    int k;
    if (!pbwsf__segment_meets(x, a, b, above, below)) {
        return;
    }
    pbwsf__normal(x[0], x[1], x[2], n);
    if (above != 0 || below != 0) {
        double u[3], v[3], height, depth;
        pbwsf__minus(a, x[0], u);
        pbwsf__minus(b, x[0], v);
        height = above == 0 ? 0 : fabs(pbwsf__dot(n, u));
        depth = below == 0 ? 0 : fabs(pbwsf__dot(n, v));
        from = to = height + depth > 0 ? height / (height + depth) : 0.5;
    }
    for (k = 0; k < 3 && above == 0 && below == 0; k++) {
        double side[3], inward[3], u[3], v[3], at_a, at_b;
        pbwsf__minus(x[(k + 1) % 3], x[k], side);
        pbwsf__cross(n, side, inward);
        pbwsf__minus(a, x[k], u);
        pbwsf__minus(b, x[k], v);
        at_a = pbwsf__dot(inward, u);
        at_b = pbwsf__dot(inward, v);
        if (at_a < 0 && at_b > at_a) {
            from = fmax(from, fmin(1, at_a / (at_a - at_b)));
        } else if (at_b < 0 && at_a > at_b) {
            to = fmin(to, at_a / (at_a - at_b));
        }
    }
    to = fmax(from, to);
    for (k = 0; k < 2; k++) {                        /* rounding must not move an end */
        const double t = k == 0 ? from : to;
        pbwsf__between(t < 1 ? a : b, b, t < 1 ? t : 0, out->at[out->count++]);
    }
}

/* Of the caller's corners: room for those of places is freed. */
static void pbwsf__load_found(const pbwsf__search *s, pbw_index id, pbwsf__triangle *t)
{
    int i;
    for (i = 0; i < 3; i++) {
        t->x[i] = s->points + 3 * (size_t)s->triangles[3 * (size_t)id + (size_t)i];
    }
}

static pbw_status pbwsf__segment_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    for (; from < to; from++) {
        const pbw_index *pair = s->found->crossings.at + 2 * from;
        double *out = s->found->segments.at + 6 * from, away = -1;
        pbwsf__triangle t, u;
        pbwsf__common common;
        int i, j;
        common.count = 0;
        pbwsf__load_found(s, pair[0], &t);
        pbwsf__load_found(s, pair[1], &u);
        for (i = 0; i < 3; i++) {
            pbwsf__add_common(u.x, t.x[i], t.x[(i + 1) % 3], &common);
            pbwsf__add_common(t.x, u.x[i], u.x[(i + 1) % 3], &common);
        }
        for (i = 0; i < common.count; i++) {
            for (j = 0; j <= i; j++) {
                const double d = pbwsf__distance(common.at[i], common.at[j]);
                if (d > away) {
                    away = d;
                    memcpy(out, common.at[j], sizeof common.at[j]);
                    memcpy(out + 3, common.at[i], sizeof common.at[i]);
                }
            }
        }
    }
    return PBW_OK;
}

/* ------------------------------------------------------------------------------------------------------
   >>faults       All that is wrong with a surface.
   In: points and triangles.  Out: lists of faults.
   ------------------------------------------------------------------------------------------------------ */
enum {
    PBWSF__LEAVES = 16,                    /* below a node that is searched at once: a power of two */
    PBWSF__PATIENCE = 1000                 /* steps: 300 are usual */
};

/* Returns signs of the triangle's area along the axes that are certain: bit k, positive along axis k; 3 + k,
   negative.  The filter is that of pbwsf__side_of: here the error is at most (3 + 16 2^-53) 2^-53 of the sum. */
static unsigned pbwsf__signs_of(const pbwsf__search *s, const double *const x[3])
{
    double u[3], v[3];
    unsigned signs = 0;
    int k;
    pbwsf__minus(x[1], x[0], u);
    pbwsf__minus(x[2], x[0], v);
    for (k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double a = u[i] * v[j], b = u[j] * v[i], error = 8e-16 * (fabs(a) + fabs(b)) + s->least;
        signs |= (unsigned)(a - b > error) << k | (unsigned)(b - a > error) << (3 + k);
    }
    return signs;
}

static pbw_status pbwsf__signs_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    for (; from < to; from++) {
        const double *x[3];
        unsigned signs;
        int sign, k;
        for (k = 0; k < 3; k++) {
            x[k] = s->places.at[s->corners.at[3 * from + (size_t)k]];
        }
        signs = pbwsf__signs_of(s, x);
        if (signs == 0 && pbwsf__axis_of(x, &sign) == 3) {
            signs = PBWSF__FLAT;
        }
        s->signs.at[from] = (unsigned char)(s->signs.at[from] | signs);
    }
    return PBW_OK;
}

/* Stars.  Seen along an axis, let all triangles at a place have areas of one sign, and each edge there exactly two of
   them, one each way round.  Then each direction around the place is covered equally often, namely as often as sides
   across from the place go up through its level, and if that is once, two of the triangles have nothing in common but
   the place, or a side.  So they need no test. */
static pbw_status pbwsf__star_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    for (; from < to; from++) {
        const pbw_index *c = s->corners.at + 3 * from;
        int i, k;
        for (i = 0; i < 3; i++) {
            pbwsf__star *star = s->stars.at + c[i];
            const double *x = s->places.at[c[i]], *a = s->places.at[c[(i + 1) % 3]];
            const double *b = s->places.at[c[(i + 2) % 3]];
            star->signs = (unsigned char)(star->signs & s->signs.at[from]);
            for (k = 0; k < 3; k++) {
                star->up[k] = (unsigned char)(star->up[k] + ((a[k] < x[k]) & (b[k] >= x[k]) & (star->up[k] < 2)));
            }
        }
    }
    return PBW_OK;
}

/* Keeps a star's signs only if they prove that its triangles do not cross each other. */
static pbw_status pbwsf__settle_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    for (; from < to; from++) {
        pbwsf__star *star = s->stars.at + from;
        const int both = star->signs | star->signs >> 3;
        star->signs = (unsigned char)(((both & 1) && star->up[1] == 1) || ((both & 2) && star->up[2] == 1)
                                      || ((both & 4) && star->up[0] == 1));
    }
    return PBW_OK;
}

/* Lists flat triangles, and leaves them and those given again out of items and corners. */
static pbw_status pbwsf__leave_out(pbwsf__search *s)
{
    pbw_status status;
    size_t i, count = 0;
    for (i = 0; i < s->triangle_count; i++) {
        if ((s->signs.at[i] & PBWSF__FLAT) != 0 && !PBW_PUSH(s->memory, s->keys, s->items.at[i])) {
            return PBW_ERROR_MEMORY;
        }
        if (s->signs.at[i] <= PBWSF__ALL_SIGNS) {
            memmove(s->corners.at + 3 * count, s->corners.at + 3 * i, 3 * sizeof *s->corners.at);
            s->items.at[count++] = s->items.at[i];
        }
    }
    s->items.count = count;
    PBW_RELEASE(s->memory, s->signs);
    status = pbwsf__sort_keys(s, s->keys.at, s->keys.count);
    for (i = 0; i < s->keys.count && status == PBW_OK; i++) {
        status = PBW_PUSH(s->memory, s->found->flat, (pbw_index)s->keys.at[i]) ? PBW_OK : PBW_ERROR_MEMORY;
    }
    PBW_RELEASE(s->memory, s->keys);
    return status;
}

/* Of a triangle the corner that all triangles from .. to - 1 have, too; PBW_NONE: none, or there is one triangle. */
static pbw_index pbwsf__common_corner(const pbw_index *corners, size_t from, size_t to)
{
    size_t i;
    int j, k;
    for (k = 0; k < 3 && to > from + 1; k++) {
        const pbw_index c = corners[3 * from + (size_t)k];
        for (i = from + 1, j = 0; i < to && j < 3; i++) {
            for (j = 0; j < 3 && corners[3 * i + (size_t)j] != c; j++) {
            }
        }
        if (j < 3) {
            return c;
        }
    }
    return PBW_NONE;
}

static void pbwsf__extend(double *low, double *high, const double *by_low, const double *by_high)
{
    int k;
    for (k = 0; k < 3; k++) {
        low[k] = by_low[k] < low[k] ? by_low[k] : low[k];
        high[k] = by_high[k] > high[k] ? by_high[k] : high[k];
    }
}

static void pbwsf__empty_node(pbwsf__node *node)
{
    int k;
    for (k = 0; k < 3; k++) {
        node->low[k] = HUGE_VAL;
        node->high[k] = -HUGE_VAL;
    }
    node->apex = PBW_NONE;
}

/* Extends a box by that of the directions from x to the places from a to b.  Rounding of each unit vector is below
   1e-15, also of the coordinates' differences.  The middle of the line between two such vectors is q off the unit
   sphere, at most a quarter of its length squared, as 1 - sqrt(1 - q) <= q; others on it are nearer. */
static void pbwsf__extend_arc(const double *x, const double *a, const double *b, pbwsf__node *arc)
{
    double u[3], v[3], w[3], p, q;
    int k, good;
    pbwsf__minus(a, x, u);
    pbwsf__minus(b, x, v);
    p = sqrt(pbwsf__dot(u, u));
    q = sqrt(pbwsf__dot(v, v));
    good = p > 1e-100 && q > 1e-100 && p < 1e100 && q < 1e100;       /* else squares may be 0, or infinite */
    for (k = 0; k < 3; k++) {
        u[k] = good ? u[k] / p : 0;
        v[k] = good ? v[k] / q : 0;
    }
    pbwsf__minus(u, v, w);
    q = good ? pbwsf__dot(w, w) / 4 + 1e-14 : 1;
    for (k = 0; k < 3; k++) {
        w[k] = (u[k] < v[k] ? u[k] : v[k]) - q;
        u[k] = (u[k] < v[k] ? v[k] : u[k]) + q;
    }
    pbwsf__extend(arc->low, arc->high, w, u);
}

/* Rounding is monotone, so that boxes that meet meet when they are rounded, too. */
static float pbwsf__float_of(double x)
{
    return x > FLT_MAX ? FLT_MAX : x < -FLT_MAX ? -FLT_MAX : (float)x;
}

static pbw_status pbwsf__leaf_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    for (; from < to; from++) {
        pbwsf__node *leaf = s->nodes.at + s->first_leaf + from, *arc = s->arcs.at + s->first_leaf + from;
        const size_t first = PBWSF__LEAF * from, next = first + PBWSF__LEAF;
        const size_t end = next < s->items.count ? next : s->items.count;
        size_t i, k;
        pbwsf__empty_node(leaf);
        pbwsf__empty_node(arc);
        arc->apex = pbwsf__common_corner(s->corners.at, first, end);
        for (i = first; i < next; i++) {
            pbwsf__slab *slab = s->slabs.at + from;
            pbwsf__node own;
            pbwsf__empty_node(&own);
            for (k = 3 * i; k < 3 * i + 3 && i < end; k++) {
                const double *x = s->places.at[s->corners.at[k]];
                pbwsf__extend(own.low, own.high, x, x);
                if (s->corners.at[k] == arc->apex) {
                    pbwsf__extend_arc(x, s->places.at[s->corners.at[3 * i + (k + 1) % 3]],
                                      s->places.at[s->corners.at[3 * i + (k + 2) % 3]], arc);
                }
            }
            pbwsf__extend(leaf->low, leaf->high, own.low, own.high);
            for (k = 0; k < 3; k++) {
                const pbw_index c = i < end ? s->corners.at[3 * i + k] : PBW_NONE;
                slab->low[k][i - first] = pbwsf__float_of(own.low[k]);
                slab->high[k][i - first] = pbwsf__float_of(own.high[k]);
                slab->proven[k][i - first] = i < end && s->stars.at[c].signs ? c : PBW_NONE;
            }
        }
    }
    return PBW_OK;
}

/* A node has no children, one, or two. */
static void pbwsf__fill_node(const pbwsf__search *s, size_t i, pbwsf__node *nodes)
{
    size_t child;
    pbwsf__empty_node(nodes + i);
    for (child = 2 * i + 1; child <= 2 * i + 2 && child < s->node_count; child++) {
        pbwsf__extend(nodes[i].low, nodes[i].high, nodes[child].low, nodes[child].high);
        nodes[i].apex = child % 2 == 1 || nodes[i].apex == nodes[child].apex ? nodes[child].apex : PBW_NONE;
    }
}

/* Fills a range of nodes of one level, which begins at first_node. */
static pbw_status pbwsf__node_range(void *arg, size_t from, size_t to)
{
    const pbwsf__search *s = (const pbwsf__search *)arg;
    for (; from < to; from++) {
        pbwsf__fill_node(s, s->first_node + from, s->nodes.at);
        pbwsf__fill_node(s, s->first_node + from, s->arcs.at);
    }
    return PBW_OK;
}

/* Makes the tree of the triangles that may meet. */
static pbw_status pbwsf__plant(pbwsf__search *s)
{
    const size_t leaves = (s->items.count + PBWSF__LEAF - 1) / PBWSF__LEAF;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t most = 1;
    while (most < leaves) {
        most *= 2;
    }
    s->first_leaf = most - 1;
    s->node_count = s->first_leaf + leaves;
    if (PBW_FIT(s->memory, s->nodes, s->node_count + 1) && PBW_FIT(s->memory, s->arcs, s->node_count + 1)
        && PBW_FIT(s->memory, s->slabs, leaves + 1)) {
        status = pbw_for(pbwsf__next_part(s, 0.05, 0), leaves, 4096, pbwsf__leaf_range, s);
    }
    for (most /= 2; most > 0 && status == PBW_OK; most /= 2) {           /* levels, the last one first */
        s->first_node = most - 1;
        status = pbw_for(pbwsf__next_part(s, 0, 0), most, 4096, pbwsf__node_range, s);
    }
    return status;
}

static pbw_status pbwsf__pair_range(void *arg, size_t from, size_t to)
{
    pbwsf__search *s = (pbwsf__search *)arg;
    for (; from < to; from++) {
        const size_t at = s->first_pairs + from;
        if (s->steps.at[at] == PBWSF__LEFT
            && !pbwsf__test_node(s, s->first_node + at, s->pairs.at + at, s->steps.at + at)) {
            return PBW_ERROR_MEMORY;
        }
    }
    return PBW_OK;
}

/* Fills in what has to fit into the rod of a node: of a leaf the corners of its triangles, of others the turned boxes
   of the children; and which way they are long, a side from the corner, or a child's rod.  Returns 0 if there is no
   part `at`. */
static int pbwsf__rod_part(const pbwsf__search *s, size_t node, size_t at, pbwsf__turned *part, double way[3])
{
    const size_t child = 2 * node + 1 + at;
    int k;
    if (node >= s->first_leaf) {
        const size_t item = PBWSF__LEAF * (node - s->first_leaf) + at / 3;
        const pbw_index *c;
        if (at >= 3 * PBWSF__LEAF || item >= s->items.count) {
            return 0;
        }
        c = s->corners.at + 3 * item;
        memset(part, 0, sizeof *part);
        memcpy(part->middle, s->places.at[c[at % 3]], sizeof part->middle);
        pbwsf__minus(s->places.at[c[(at + 1) % 3]], part->middle, way);
        return 1;
    }
    if (at >= 2 || child >= s->node_count || s->nodes.at[child].low[0] > s->nodes.at[child].high[0]) {
        return 0;                                    /* there are no triangles below it */
    }
    if (!pbwsf__turned_of(s, child, part)) {
        memset(way, 0, 3 * sizeof *way);
        return 1;
    }
    for (k = 0; k < 3; k++) {
        way[k] = part->half[0] * part->axes[0][k];
    }
    return 1;
}

/* Makes a rod around the parts of a node, unless it is not four times as long as wide. */
static void pbwsf__fill_rod(const pbwsf__search *s, size_t node)
{
    pbwsf__rod *rod = s->rods.at + node;
    pbwsf__turned part;
    double axes[3][3], sum[3] = { 0, 0, 0 }, away[3], length;
    size_t i;
    int k, pass;
    rod->half[0] = -1;
    for (i = 0; pbwsf__rod_part(s, node, i, &part, away); i++) {
        const double sign = pbwsf__dot(sum, away) < 0 ? -1 : 1;
        for (k = 0; k < 3; k++) {
            sum[k] += sign * away[k];
        }
    }
    length = sqrt(pbwsf__dot(sum, sum));
    for (k = 0; k < 3 && length > 1e-80; k++) {
        rod->along[k] = sum[k] / length;
        rod->middle[k] = s->nodes.at[node].low[k];
    }
    if (length <= 1e-80 || !pbwsf__axes_of(rod->along, axes)) {
        return;
    }
    for (pass = 0; pass < 2; pass++) {               /* the middle of all parts, and the extents from there */
        double low[3] = { HUGE_VAL, HUGE_VAL, HUGE_VAL }, high[3] = { -HUGE_VAL, -HUGE_VAL, -HUGE_VAL };
        for (i = 0; pbwsf__rod_part(s, node, i, &part, away); i++) {
            pbwsf__minus(part.middle, rod->middle, away);
            for (k = 0; k < 3; k++) {
                const double at = pbwsf__dot(away, axes[k]), half = pbwsf__half_along(&part, axes[k])
                           + 1e-14 * (fabs(away[0]) + fabs(away[1]) + fabs(away[2]));
                low[k] = fmin(low[k], at - half);
                high[k] = fmax(high[k], at + half);
            }
        }
        for (k = 0; k < 3; k++) {
            for (i = 0; i < 3 && pass == 0; i++) {
                rod->middle[k] += axes[i][k] * (low[i] + high[i]) / 2;
            }
            away[k] = fmax(-low[k], high[k]);
        }
    }
    if (4 * fmax(away[1], away[2]) < away[0]) {
        memcpy(rod->half, away, sizeof rod->half);
    }
}

static pbw_status pbwsf__rod_range(void *arg, size_t from, size_t to)
{
    const pbwsf__search *s = (const pbwsf__search *)arg;
    for (from += s->first_node, to += s->first_node; from < to && from < s->node_count; from++) {
        pbwsf__fill_rod(s, from);
    }
    return PBW_OK;
}

/* Makes the rods of all nodes. */
static pbw_status pbwsf__make_rods(pbwsf__search *s)
{
    pbw_status status = PBW_FIT(s->memory, s->rods, s->node_count) ? PBW_OK : PBW_ERROR_MEMORY;
    size_t most;
    s->rods.count = s->node_count;
    for (most = s->first_leaf + 1; most > 0 && status == PBW_OK; most /= 2) {    /* levels, the last one first */
        s->first_node = most - 1;
        status = pbw_for(pbwsf__next_part(s, 0, 0), most, 1024, pbwsf__rod_range, s);
    }
    return status;
}

/* Searches those of the nodes from .. to - 1 of a level that are left, and counts those that are left then. */
static pbw_status pbwsf__search_left(pbwsf__search *s, size_t from, size_t to, double share, size_t *left)
{
    const size_t most = (s->first_leaf + 1) / PBWSF__LEAVES;
    pbw_status status;
    s->first_node = most > 0 ? most - 1 : 0;
    s->first_pairs = from;
    status = pbw_for(pbwsf__next_part(s, share, 0), to - from, 1, pbwsf__pair_range, s);
    for (; from < to; from++) {
        *left += s->steps.at[from] == PBWSF__LEFT;
    }
    return status;
}

/* Fills the pairs of each node of a level.  Rods take about as long as all searches of a usual surface, so they are
   made if one search in eight takes far more steps than usual, or if those that do so take more than all others. */
static pbw_status pbwsf__find_pairs(pbwsf__search *s)
{
    const size_t leaves = (s->items.count + PBWSF__LEAF - 1) / PBWSF__LEAF;
    const size_t nodes = (leaves + PBWSF__LEAVES - 1) / PBWSF__LEAVES;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t from, to, left = 0;
    s->patience = s->least < HUGE_VAL ? (size_t)PBWSF__PATIENCE : (size_t)-1;
    if (PBW_ZEROS(s->memory, s->pairs, nodes + 1) && PBW_FIT(s->memory, s->steps, nodes + 1)) {
        status = PBW_OK;
    }
    for (from = 0; from < nodes && status == PBW_OK; from++) {
        s->steps.at[s->steps.count++] = PBWSF__LEFT;
    }
    for (from = 0; from < nodes && 8 * left <= from && status == PBW_OK; from = to) {
        to = 2 * from + 64 < nodes ? 2 * from + 64 : nodes;
        status = pbwsf__search_left(s, from, to, 0.2 * (double)(to - from) / (double)nodes, &left);
    }
    if (status == PBW_OK && left > 0 && from == nodes && 8 * left <= nodes) {
        s->patience = PBWSF__PATIENCE * (nodes / left);
        left = 0;
        status = pbwsf__search_left(s, 0, nodes, 0.05, &left);
    }
    if (status == PBW_OK && left > 0) {
        status = pbwsf__make_rods(s);
        s->patience = (size_t)-1;
        status = status != PBW_OK ? status : pbwsf__search_left(s, 0, nodes, 0.05, &left);
    }
    return status;
}

/* Puts `count` items of `each` numbers in an order. */
static int pbwsf__permute(pbw_memory *memory, const pbw_index *order, size_t count, size_t each,
                          pbwsf__indices *items)
{
    pbwsf__indices sorted = { NULL, 0, 0 };
    size_t i;
    if (!PBW_FIT(memory, sorted, each * count + 1)) {
        return 0;
    }
    for (i = 0; i < each * count; i++) {
        sorted.at[i] = items->at[each * order[i / each] + i % each];
    }
    sorted.count = each * count;
    PBW_RELEASE(memory, *items);
    *items = sorted;
    return 1;
}

/* Sorts pairs of indices, and numbers beside them if there are some. */
static pbw_status pbwsf__sort_pairs(pbwsf__search *s, pbwsf__indices *pairs, pbwsf__indices *beside)
{
    const size_t count = pairs->count / 2;
    pbwsf__keys keys = { NULL, 0, 0 };
    pbwsf__indices order = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i;
    if (PBW_FIT(s->memory, keys, count + 1) && PBW_FIT(s->memory, order, count + 1)) {
        for (i = 0; i < count; i++) {
            keys.at[i] = (uint64_t)pairs->at[2 * i] << 32 | pairs->at[2 * i + 1];
        }
        status = pbw_sort(keys.at, count, pbwsf__next_part(s, 0.01, 0), order.at);
    }
    PBW_RELEASE(s->memory, keys);
    if (status == PBW_OK && (!pbwsf__permute(s->memory, order.at, count, 2, pairs)
                             || (beside != NULL && !pbwsf__permute(s->memory, order.at, count, 1, beside)))) {
        status = PBW_ERROR_MEMORY;
    }
    PBW_RELEASE(s->memory, order);
    return status;
}

static pbw_status pbwsf__gather_pairs(pbwsf__search *s)
{
    pbwsf__indices *out = &s->found->crossings;
    pbw_status status;
    size_t i, k, count = 0;
    for (i = 0; i < s->pairs.count; i++) {
        count += s->pairs.at[i].count;
    }
    if (!PBW_FIT(s->memory, *out, 2 * count + 1)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < s->pairs.count; i++) {
        for (k = 0; k < s->pairs.at[i].count; k++) {
            out->at[out->count++] = (pbw_index)(s->pairs.at[i].at[k] >> 32);
            out->at[out->count++] = (pbw_index)(s->pairs.at[i].at[k] & 0xffffffffu);
        }
        PBW_RELEASE(s->memory, s->pairs.at[i]);
    }
    status = pbwsf__sort_pairs(s, out, NULL);
    if (status == PBW_OK && !PBW_FIT(s->memory, s->found->segments, 6 * count + 1)) {
        status = PBW_ERROR_MEMORY;
    }
    return status != PBW_OK ? status : pbw_for(pbwsf__next_part(s, 0.05, 0), count, 256, pbwsf__segment_range, s);
}

static pbw_status pbwsf__find_all(pbwsf__search *s)
{
    const size_t count = s->triangle_count;
    pbw_status status = pbwsf__weld(s);
    size_t i;
    s->least = 1e-230;
    for (i = 0; i < 3 * s->point_count; i++) {
        s->least = fabs(s->points[i]) < 1e90 ? s->least : HUGE_VAL;
    }
    status = status != PBW_OK ? status : pbwsf__sort_triangles(s);
    status = status != PBW_OK ? status : pbwsf__list_edges(s);
    status = status != PBW_OK ? status : pbw_for(pbwsf__next_part(s, 0.02, 0), count, 4096, pbwsf__signs_range, s);
    status = status != PBW_OK ? status : pbwsf__in_order(s, 0.04, count, pbwsf__star_range);
    status = status != PBW_OK ? status
           : pbw_for(pbwsf__next_part(s, 0.01, 0), s->first.count, 16384, pbwsf__settle_range, s);
    status = status != PBW_OK ? status : pbwsf__leave_out(s);
    status = status != PBW_OK ? status : pbwsf__plant(s);
    status = status != PBW_OK ? status : pbwsf__sort_pairs(s, &s->found->edges, &s->found->edge_triangles);
    status = status != PBW_OK ? status : pbwsf__sort_pairs(s, &s->found->duplicates, NULL);
    status = status != PBW_OK ? status : pbwsf__find_pairs(s);
    return status != PBW_OK ? status : pbwsf__gather_pairs(s);
}

/* Begins a search; pbwsf__free_search ends it, and leaves what it found. */
static pbw_status pbwsf__start_search(const double *points, size_t point_count, const pbw_index *triangles,
                                      size_t triangle_count, const pbw_options *options, pbwsf__search *s)
{
    pbw_memory memory;
    pbw_memory_start(&memory, options);
    memset(s, 0, sizeof *s);
    s->found = (pbwsf__found *)pbw_memory_resize(&memory, NULL, 0, 1, sizeof *s->found);
    if (s->found == NULL) {
        return PBW_ERROR_MEMORY;
    }
    memset(s->found, 0, sizeof *s->found);
    s->found->memory = memory;
    s->memory = &s->found->memory;
    s->given = options;
    s->points = points;
    s->point_count = point_count;
    s->triangles = triangles;
    s->triangle_count = triangle_count;
    return PBW_OK;
}

static void pbwsf__free_search(pbwsf__search *s)
{
    size_t i;
    for (i = 0; i < s->pairs.count; i++) {
        PBW_RELEASE(s->memory, s->pairs.at[i]);
    }
    PBW_RELEASE(s->memory, s->pairs);
    PBW_RELEASE(s->memory, s->rank);
    PBW_RELEASE(s->memory, s->first);
    PBW_RELEASE(s->memory, s->places);
    PBW_RELEASE(s->memory, s->corners);
    PBW_RELEASE(s->memory, s->items);
    PBW_RELEASE(s->memory, s->room);
    PBW_RELEASE(s->memory, s->degree);
    PBW_RELEASE(s->memory, s->keys);
    PBW_RELEASE(s->memory, s->ends);
    PBW_RELEASE(s->memory, s->signs);
    PBW_RELEASE(s->memory, s->stars);
    PBW_RELEASE(s->memory, s->nodes);
    PBW_RELEASE(s->memory, s->arcs);
    PBW_RELEASE(s->memory, s->slabs);
    PBW_RELEASE(s->memory, s->rods);
    PBW_RELEASE(s->memory, s->steps);
}

static void pbwsf__show(const pbwsf__found *f, pbw_surface_faults *faults)
{
    faults->crossing_count = f->crossings.count / 2;
    faults->crossings = f->crossings.at;
    faults->segments = f->segments.at;
    faults->flat_count = f->flat.count;
    faults->flat = f->flat.at;
    faults->duplicate_count = f->duplicates.count / 2;
    faults->duplicates = f->duplicates.at;
    faults->edge_count = f->edges.count / 2;
    faults->edges = f->edges.at;
    faults->edge_triangles = f->edge_triangles.at;
    faults->repeated_count = f->repeated.count / 2;
    faults->repeated = f->repeated.at;
}

PBWDEF pbw_status pbw_surface_crossings(const double *points, size_t point_count, const pbw_index *triangles,
                                        size_t triangle_count, const pbw_options *options,
                                        pbw_surface_faults *faults)
{
    pbwsf__search search;
    pbw_status status;
    if (faults == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(faults, 0, sizeof *faults);
    if (triangle_count >= PBW_NONE / 3) {
        return PBW_ERROR_TOO_LARGE;
    }
    status = pbwsf__check_input(points, point_count, triangles, triangle_count, options);
    if (status != PBW_OK) {
        return status;
    }
    status = pbwsf__start_search(points, point_count, triangles, triangle_count, options, &search);
    if (status != PBW_OK) {
        return status;
    }
    status = pbwsf__find_all(&search);
    pbwsf__free_search(&search);
    faults->memory = search.found;
    if (status == PBW_OK) {
        pbwsf__show(search.found, faults);
    } else {
        pbw_surface_faults_free(faults);
    }
    return status;
}

PBWDEF void pbw_surface_faults_free(pbw_surface_faults *faults)
{
    if (faults != NULL && faults->memory != NULL) {
        pbwsf__found *f = (pbwsf__found *)faults->memory;
        pbw_memory memory = f->memory;
        PBW_RELEASE(&memory, f->crossings);
        PBW_RELEASE(&memory, f->segments);
        PBW_RELEASE(&memory, f->flat);
        PBW_RELEASE(&memory, f->duplicates);
        PBW_RELEASE(&memory, f->edges);
        PBW_RELEASE(&memory, f->edge_triangles);
        PBW_RELEASE(&memory, f->repeated);
        (void)pbw_memory_resize(&memory, f, 1, 0, sizeof *f);
    }
    if (faults != NULL) {
        memset(faults, 0, sizeof *faults);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>seam         What pbw_improve.h, pbw_mesh3.h, pbw_wrap.h and others use of the rooms above.
   Holds: the list is what they use, tests/seam.sh compares; whoever changes what a name in it means, raises it.

   They are compiled behind this header, in one source file, and refuse another number.

     PBWSF__SHARED      improve                             interface
     pbwsf__counts      improve mesh3                       arrays
     pbwsf__flags       improve mesh3                       arrays
     pbwsf__indices     improve mesh3 wrap                  arrays
     pbwsf__numbers     improve mesh3 wrap                  arrays
     pbwsf__pair        mesh3                               arrays
     pbwsf__pairs       improve mesh3                       arrays
     pbwsf__quadruples  improve mesh3 wrap                  arrays
     pbwsf__triple      mesh3                               arrays
     pbwsf__triples     mesh3 wrap                          arrays
     pbwsf__vector      mesh3 wrap                          arrays
     pbwsf__vectors     improve mesh3 wrap                  arrays
     pbwsf__between     improve mesh3 wrap                  vectors
     pbwsf__cross       improve mesh3 wrap                  vectors
     pbwsf__distance    adapt3 improve mesh3 stuffing wrap  vectors
     pbwsf__dot         improve mesh3 wrap                  vectors
     pbwsf__minus       improve mesh3 wrap                  vectors
     pbwsf__normal      improve mesh3 wrap                  vectors
     PBWSF__DEPTH       wrap                                tree
     pbwsf__box         wrap                                tree
     pbwsf__bytes       adapt3 improve mesh3                tree
     pbwsf__corner      mesh3 wrap                          tree
     pbwsf__end_of      wrap                                tree
     pbwsf__first_of    wrap                                tree
     pbwsf__normal_of   mesh3                               tree
     pbwsf__tree        wrap                                tree
     pbwsf__box_meets   wrap                                queries
     pbwsf__closest     mesh3                               queries
     pbwsf__find_open   mesh3                               queries
     pbwsf__is_near     mesh3 wrap                          queries
     pbwsf__nearest_in  mesh3 wrap                          queries
     pbwsf__ray         mesh3                               queries
   ------------------------------------------------------------------------------------------------------ */
#define PBWSF__SEAM 1

PBW_CONTRACTION_ON
#endif /* PBW_SURFACE_IMPLEMENTATION */
