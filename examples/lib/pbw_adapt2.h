/* pbw_adapt2.h - v0.2.0 - plane meshes: quality, smoothing, adaptation - MIT-0

   QUICK START
   In one source file, define PBW_ADAPT2_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h and pbw_mesh2.h, with their implementations in some source file.

       pbw_plane next = {0};                                                 // plane: of pbw_mesh2.h
       double *sizes = (double *)malloc(plane.point_count * sizeof *sizes);
       pbw_plane_sizes(&plane, error, 2 * plane.triangle_count, sizes);      // error: one number a triangle
       if (pbw_plane_adapt(&plane, sizes, NULL, NULL, &next, NULL) != PBW_OK) puts(next.what);
       pbw_plane_transfer(&plane, &next, values, 1, new_values, NULL);       // one number a point
       pbw_plane_smooth(&next, PBW_PLANE_ODT, 5, NULL, NULL);
       pbw_plane_free(&next);

   FUNCTIONS
     pbw_plane_measure_of      a measure of quality of one triangle
     pbw_plane_measure_name    its name
     pbw_plane_quality_of      the range and mean of a measure in a mesh
     pbw_plane_smooth          moves points to better places
     pbw_plane_sizes           sizes at points, of errors of triangles
     pbw_plane_adapt           a mesh of other sizes
     pbw_plane_from_triangles  a plane of triangles that are there
     pbw_plane_transfer        values at the points of another mesh

   HOW
   A mesh that changes is built again, from the points that stay and the edges of its segments: the constrained
   triangulation takes less than a microsecond a point.  The numbers of segments and regions are kept, and edges of
   segments without numbers.

   PROMISES  (tests/test_adapt2.c guards them)
     Points on no segment may move or be removed.  Adaptation may also remove a point between two edges of one line
     with the same numbers.  All others stay where they are, bit for bit.
     Smoothing never makes the least angle of the mesh smaller, and moves no point across a segment.
     The answer is the same for any number of threads.

   LIMITS
   Lloyd's way and ODT even out sizes: a graded mesh loses some of its grading with every round.

   CONTENTS
     >>interface    types and functions
     >>memory       arrays of a call
     >>quality      measures of triangles
     >>stars        triangles at points
     >>remake       building a plane again
     >>smoothing    points that move
     >>sizes        sizes of errors; sizes that grow by a bound
     >>coarsening   which points stay, and adaptation
     >>triangles    a plane from triangles
     >>transfer     values at the points of another mesh

   CONFIGURATION MACROS
     PBW_ADAPT2_IMPLEMENTATION    in one source file: compile the implementation there
*/
#ifndef PBW_ADAPT2_H
#define PBW_ADAPT2_H
#ifndef PBW_MESH2_H
#include "pbw_mesh2.h"
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */

#ifdef __cplusplus
extern "C" {
#endif

/* ---- quality */

/* Measures of a triangle, by their names in Verdict (V) and Gmsh (G); * = 1 for the equilateral triangle, 0 for a
   flat one.  l: lengths of the edges; A: area; r, R: radii of the circles inside and around. */
typedef enum pbw_plane_measure {
    PBW_PLANE_MIN_ANGLE = 0,               /* V "minimum angle": in degrees */
    PBW_PLANE_MAX_ANGLE,                   /* V "maximum angle": in degrees */
    PBW_PLANE_GAMMA,                       /* G "gamma": 2 r / R * */
    PBW_PLANE_RADIUS_RATIO,                /* V "radius ratio": R / (2 r), from 1 */
    PBW_PLANE_ASPECT_RATIO,                /* V "aspect ratio": longest l * sum of l / (4 sqrt 3 A), from 1 */
    PBW_PLANE_EDGE_RATIO,                  /* V "edge ratio": longest l / shortest l, from 1 */
    PBW_PLANE_SHAPE,                       /* V "shape", G "SICN": 4 sqrt 3 A / sum of l^2 * */
    PBW_PLANE_CONDITION,                   /* V "condition", "aspect Frobenius": 1 / shape, from 1 */
    PBW_PLANE_SCALED_JACOBIAN,             /* V "scaled Jacobian": 4 A / sqrt 3 / product of the longer two l * */
    PBW_PLANE_AREA,                        /* V "area" */
    PBW_PLANE_MEASURES                     /* how many there are */
} pbw_plane_measure;

#define PBW_PLANE_BINS 20
typedef struct pbw_plane_quality {
    double least, most, mean;              /* 0 of no triangles */
    double low, high;                      /* of all bins together; what is outside counts in the first or last */
    size_t bins[PBW_PLANE_BINS];
} pbw_plane_quality;

/* The measure of the triangle a b c, counter-clockwise; of a flat one it may be infinite. */
PBWDEF double pbw_plane_measure_of(pbw_plane_measure measure, const double *a, const double *b, const double *c);
/* "minimum angle" and so on, as Verdict has it; "gamma" as Gmsh has it. */
PBWDEF const char *pbw_plane_measure_name(pbw_plane_measure measure);
/* Least, most, mean and histogram of a measure. */
PBWDEF pbw_plane_quality pbw_plane_quality_of(const pbw_plane *plane, pbw_plane_measure measure);

/* ---- smoothing */

typedef enum pbw_plane_way {
    PBW_PLANE_LAPLACE = 0,                 /* a point goes to the mean of its neighbours */
    PBW_PLANE_LLOYD,                       /* to the centroid of its Voronoi cell */
    PBW_PLANE_ODT                          /* to the mean of its triangles' circumcentres, weighted by area: optimal
                                              Delaunay triangulation (Chen 2004) */
} pbw_plane_way;

/* Moves the points on no segment, `rounds` times; each round ends with a triangulation.  Points keep their numbers.
   A point goes half as far, or stays, if the least angle of its triangles would fall, and would be below 30 degrees
   or below the least angle of the mesh.  keep: one a point, 1 = it must stay; NULL = only those on segments must.  Of
   options only `build` counts; NULL = defaults.  Fails as pbw_plane_make; the plane is then unchanged, except for
   `what`. */
PBWDEF pbw_status pbw_plane_smooth(pbw_plane *plane, pbw_plane_way way, int rounds, const unsigned char *keep,
                                   const pbw_plane_options *options);

/* ---- adaptation */

/* Fills sizes, one a point: edge lengths for a mesh of about `count` triangles with equal errors.  error: per
   triangle, proportional to the square of its size, as the energy norm of the error of linear elements over one
   triangle is. */
PBWDEF void pbw_plane_sizes(const pbw_plane *plane, const double *error, size_t count, double *sizes);

/* Makes a finer mesh where edges are longer than the sizes of their ends, a coarser one where they are shorter than
   half.  sizes: one a point, 0 = any.  keep: one a point, 1 = it must stay; NULL = only the ends of segments must.
   options: as for pbw_plane_make, but the domain is kept, whatever its rule, and the mesh is always refined.  result:
   overwritten; fails as pbw_plane_make, and without triangles.  from: room for plane->point_count numbers, or NULL;
   gets the old number of point i of the result, for i < result->input_count.  edge_segments and region_seeds of the
   result have the caller's numbers, as in the old mesh; region_windings are 1. */
PBWDEF pbw_status pbw_plane_adapt(const pbw_plane *plane, const double *sizes, const unsigned char *keep,
                                  const pbw_plane_options *options, pbw_plane *result, pbw_index *from);

/* Makes a plane of triangles of either orientation, to be refined, adapted or smoothed.  What they cover becomes the
   domain, which is triangulated again; edges between triangles of different regions stay, and so do the segments.
   input: the points; segments that are edges of the triangles or lie elsewhere, with their segment_ids; sizes.  The
   rest of it does not count.  regions: numbers, one a triangle, that become region_seeds, so that all triangles
   keep theirs; NULL = PBW_NONE for all.  Lists of edge_segments have the ids of segments only: that of a border on no
   segment is empty.  Where no two triangles have an edge in common, as in files of triangles with corners of their
   own, points at one place count as one.  plane: overwritten.  Returns PBW_ERROR_ARGUMENT without triangles, for ids
   out of range, for two triangles on one side of an edge, and where borders of triangles or segments cross, or fails
   as pbw_plane_make; plane->what says why. */
PBWDEF pbw_status pbw_plane_from_triangles(const pbw_plane_input *input, const pbw_index *triangles,
                                           const pbw_index *regions, size_t triangle_count,
                                           const pbw_plane_options *options, pbw_plane *plane);

/* Computes values at the points of another mesh of the domain: linear in each triangle of `from`, and not outside of
   the values at its corners; outside of all triangles the value at the nearest place.  width: numbers a point;
   values: from->point_count * width, out: room for to->point_count * width.  Of options only `build` counts; NULL =
   defaults.  Returns PBW_ERROR_ARGUMENT if `from` has no triangles, PBW_ERROR_MEMORY or PBW_CANCELLED. */
PBWDEF pbw_status pbw_plane_transfer(const pbw_plane *from, const pbw_plane *to, const double *values,
                                     size_t width, double *out, const pbw_plane_options *options);

#ifdef __cplusplus
}
#endif
#endif /* PBW_ADAPT2_H */

#if defined(PBW_ADAPT2_IMPLEMENTATION) && !defined(PBWA2__IMPLEMENTED)
#define PBWA2__IMPLEMENTED

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* No contraction: fused operations would give other coordinates. */
PBW_CONTRACTION_OFF

/* ------------------------------------------------------------------------------------------------------
   >>memory       Memory: a few arrays a call, freed together.
   Holds: used = the sum of the arrays, and of planes that the call holds; over the limit there are no more.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWA2__ARRAYS = 24 };

typedef struct pbwa2__memory {
    pbw_memory memory;
    void *data[PBWA2__ARRAYS];
    size_t bytes[PBWA2__ARRAYS];
    int count;
} pbwa2__memory;

static void pbwa2__start(pbwa2__memory *memory, const pbw_plane_options *options)
{
    memset(memory, 0, sizeof *memory);
    pbw_memory_start(&memory->memory, options != NULL ? options->build : NULL);
}

/* Returns zeroes, or NULL. */
static void *pbwa2__zeros(pbwa2__memory *memory, size_t count, size_t size)
{
    const size_t bytes = (count + 1) * size;
    void *data = count > (SIZE_MAX >> 1) / size - 1 || memory->count == PBWA2__ARRAYS ? NULL
               : pbw_memory_resize(&memory->memory, NULL, 0, bytes, 1);
    if (data != NULL) {
        memset(data, 0, bytes);
        memory->data[memory->count] = data;
        memory->bytes[memory->count++] = bytes;
    }
    return data;
}

static void pbwa2__end(pbwa2__memory *memory)
{
    while (memory->count > 0) {
        memory->count--;
        (void)pbw_memory_resize(&memory->memory, memory->data[memory->count], memory->bytes[memory->count], 0, 1);
    }
}

/* Makes a plane within the memory that is not held. */
static pbw_status pbwa2__make(const pbwa2__memory *memory, const pbw_plane_input *input,
                              const pbw_plane_options *options, pbw_plane *plane)
{
    pbw_plane_options own = *options;
    pbw_options build;
    memset(&build, 0, sizeof build);
    if (own.build != NULL) {
        build = *own.build;
        build.stride = 0;
    }
    own.build = &build;
    build.memory_limit = pbw_memory_left(&memory->memory);
    return pbw_plane_make(input, &own, plane);
}

/* Reports PBW_STAGE_WORK before each 1024th item of a loop.  Returns nonzero if the call is cancelled. */
static int pbwa2__step(const pbw_plane_options *options, size_t i, size_t count)
{
    const pbw_options *build = options != NULL ? options->build : NULL;
    return i % 1024 == 0 && build != NULL && build->progress != NULL
        && build->progress(build->progress_user, PBW_STAGE_WORK, (double)i / (double)count) != 0;
}

static pbw_status pbwa2__say(pbw_plane *plane, pbw_status status, const char *text)
{
    snprintf(plane->what, sizeof plane->what, "%s", text != NULL ? text : pbw_status_string(status));
    return status;
}

static const double *pbwa2__at(const double *points, pbw_index v)
{
    return points + 2 * (size_t)v;
}

static double pbwa2__cross(const double *a, const double *b, const double *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static double pbwa2__apart2(const double *a, const double *b)
{
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
}

/* ------------------------------------------------------------------------------------------------------
   >>quality      Quality.
   In: triangles.  Out: measures, and how they spread.
   ------------------------------------------------------------------------------------------------------ */
#define PBWA2__SQRT3 1.7320508075688772
#define PBWA2__DEGREES 57.295779513082323

PBWDEF const char *pbw_plane_measure_name(pbw_plane_measure measure)
{
    static const char *const names[] = { "minimum angle", "maximum angle", "gamma", "radius ratio", "aspect ratio",
                                         "edge ratio", "shape", "condition", "scaled Jacobian", "area" };
    return (unsigned)measure < PBW_PLANE_MEASURES ? names[measure] : "";
}

PBWDEF double pbw_plane_measure_of(pbw_plane_measure measure, const double *a, const double *b, const double *c)
{
    const double twice = pbwa2__cross(a, b, c);
    const double u = sqrt(pbwa2__apart2(a, b)), v = sqrt(pbwa2__apart2(b, c)), w = sqrt(pbwa2__apart2(c, a));
    const double most = fmax(fmax(u, v), w), least = fmin(fmin(u, v), w);
    const double middle = fmax(fmin(u, v), fmin(fmax(u, v), w));
    const double sum = u + v + w, squares = u * u + v * v + w * w;
    switch (measure) {
    case PBW_PLANE_MIN_ANGLE:                        /* between the longer two edges */
        return PBWA2__DEGREES * atan2(twice, (most * most + middle * middle - least * least) / 2);
    case PBW_PLANE_MAX_ANGLE:
        return PBWA2__DEGREES * atan2(twice, (least * least + middle * middle - most * most) / 2);
    case PBW_PLANE_GAMMA:                            /* r = 2 A / sum, R = u v w / (4 A) */
        return u * v * w > 0 ? 4 * twice * twice / (u * v * w * sum) : 0;
    case PBW_PLANE_RADIUS_RATIO:
        return u * v * w * sum / (4 * twice * twice);
    case PBW_PLANE_ASPECT_RATIO:
        return most * sum / (2 * PBWA2__SQRT3 * twice);
    case PBW_PLANE_EDGE_RATIO:
        return most / least;
    case PBW_PLANE_SHAPE:
        return squares > 0 ? 2 * PBWA2__SQRT3 * twice / squares : 0;
    case PBW_PLANE_CONDITION:
        return squares / (2 * PBWA2__SQRT3 * twice);
    case PBW_PLANE_SCALED_JACOBIAN:
        return most * middle > 0 ? 2 / PBWA2__SQRT3 * twice / (most * middle) : 0;
    default:
        return twice / 2;
    }
}

PBWDEF pbw_plane_quality pbw_plane_quality_of(const pbw_plane *plane, pbw_plane_measure measure)
{
    pbw_plane_quality q;
    size_t i;
    double sum = 0;
    int pass;
    memset(&q, 0, sizeof q);
    for (pass = 0; pass < 2 && plane->triangle_count > 0; pass++) {
        for (i = 0; i < plane->triangle_count; i++) {
            const pbw_index *v = plane->triangles + 3 * i;
            const double x = pbw_plane_measure_of(measure, pbwa2__at(plane->points, v[0]),
                                                  pbwa2__at(plane->points, v[1]), pbwa2__at(plane->points, v[2]));
            if (pass == 0) {
                q.least = i == 0 ? x : fmin(q.least, x);
                q.most = i == 0 ? x : fmax(q.most, x);
                sum += x;
            } else {
                const double at = floor((x - q.low) / (q.high - q.low) * PBW_PLANE_BINS);
                q.bins[at >= PBW_PLANE_BINS ? PBW_PLANE_BINS - 1 : at > 0 ? (int)at : 0]++;
            }
        }
        q.mean = sum / (double)plane->triangle_count;
        q.low = measure == PBW_PLANE_RADIUS_RATIO || measure == PBW_PLANE_ASPECT_RATIO
             || measure == PBW_PLANE_EDGE_RATIO || measure == PBW_PLANE_CONDITION ? 1
              : measure == PBW_PLANE_MAX_ANGLE ? 60 : 0;
        q.high = measure == PBW_PLANE_MIN_ANGLE ? 60 : measure == PBW_PLANE_MAX_ANGLE ? 180
               : measure == PBW_PLANE_AREA ? q.most : q.low >= 1 ? 5 : 1;
    }
    return q;
}

/* ------------------------------------------------------------------------------------------------------
   >>stars        Triangles at points.
   In: a plane.  Out: the triangles of point v are item[first[v]] .. item[first[v+1]-1], ascending.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwa2__stars { size_t *first; pbw_index *item; } pbwa2__stars;

static int pbwa2__find_stars(pbwa2__memory *memory, const pbw_plane *plane, pbwa2__stars *stars)
{
    const size_t n = plane->point_count, corners = 3 * plane->triangle_count;
    size_t i;
    stars->first = (size_t *)pbwa2__zeros(memory, n + 2, sizeof *stars->first);
    stars->item = (pbw_index *)pbwa2__zeros(memory, corners, sizeof *stars->item);
    if (stars->first == NULL || stars->item == NULL) {
        return 0;
    }
    for (i = 0; i < corners; i++) {
        stars->first[plane->triangles[i] + 2]++;
    }
    for (i = 2; i < n + 2; i++) {
        stars->first[i] += stars->first[i - 1];
    }
    for (i = 0; i < corners; i++) {
        stars->item[stars->first[plane->triangles[i] + 1]++] = (pbw_index)(i / 3);
    }
    return 1;
}

/* ------------------------------------------------------------------------------------------------------
   >>remake       Building a plane again.
   In: a plane, the new places of its points, which of them stay.
   Out: the plane of those points and of the edges of segments; edges are joined over their points that do not stay.
   The domain is what the border winds round; edges inside of it occur in both directions, and add up to 0.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwa2__remake {
    const pbw_plane *old;
    const double *points;
    const unsigned char *stays;
    const double *sizes;                   /* per old point, or NULL */
    pbw_index *number;                     /* per old point: its new one */
    pbw_index *sides;                      /* per old edge: the regions to its left and right, PBW_NONE outside */
    pbw_index *segments, *ids, *lefts;
    size_t segment_count;
} pbwa2__remake;

static size_t pbwa2__id_count(const pbw_plane *p, size_t edge)
{
    return p->edge_first[edge + 1] - p->edge_first[edge];
}

/* Adds a segment with a region of the old plane to its left. */
static void pbwa2__emit(pbwa2__remake *a, pbw_index u, pbw_index v, pbw_index id, pbw_index region)
{
    a->segments[2 * a->segment_count] = a->number[u];
    a->segments[2 * a->segment_count + 1] = a->number[v];
    a->lefts[a->segment_count] = region != PBW_NONE ? a->old->region_seeds[region] : PBW_NONE;
    a->ids[a->segment_count++] = id;
}

/* Walks from point u along edge e to the first point that stays.  Adds the segment from u to there, unless the walk
   from the other end adds it. */
static void pbwa2__chain(pbwa2__remake *a, pbw_index u, size_t e, const size_t *edges_at)
{
    const pbw_plane *p = a->old;
    const size_t start = e, ids = pbwa2__id_count(p, e);
    const size_t along = p->edges[2 * e] == u;
    const pbw_index left = a->sides[2 * e + !along], right = a->sides[2 * e + along];
    pbw_index at = p->edges[2 * e + along];
    size_t i;
    while (!a->stays[at]) {
        e = edges_at[at] ^ e;
        at = p->edges[2 * e] == at ? p->edges[2 * e + 1] : p->edges[2 * e];
    }
    if (e < start || (e == start && !along)) {
        return;
    }
    for (i = 0; i < ids || i == 0; i++) {            /* one way round the border, else both */
        const pbw_index id = ids > 0 ? p->edge_segments[p->edge_first[start] + i] : PBW_NONE;
        if (left != PBW_NONE || i > 0) {
            pbwa2__emit(a, u, at, id, left);
        }
        if (right != PBW_NONE || i > 0) {
            pbwa2__emit(a, at, u, id, right);
        }
    }
}

static int pbwa2__find_segments(pbwa2__remake *a, pbwa2__memory *memory)
{
    const pbw_plane *p = a->old;
    size_t *edges_at = (size_t *)pbwa2__zeros(memory, p->point_count, sizeof *edges_at); /* their numbers, xor'ed */
    size_t i, most = 2 * p->edge_count;
    if (p->edge_count > 0) {
        most += 2 * p->edge_first[p->edge_count];
    }
    a->sides = (pbw_index *)pbwa2__zeros(memory, p->edge_count, 2 * sizeof *a->sides);
    a->segments = (pbw_index *)pbwa2__zeros(memory, most, 2 * sizeof *a->segments);
    a->ids = (pbw_index *)pbwa2__zeros(memory, most, sizeof *a->ids);
    a->lefts = (pbw_index *)pbwa2__zeros(memory, most, sizeof *a->lefts);
    if (edges_at == NULL || a->sides == NULL || a->segments == NULL || a->ids == NULL || a->lefts == NULL) {
        return 0;
    }
    memset(a->sides, 255, 2 * p->edge_count * sizeof *a->sides);
    for (i = 0; i < 3 * p->triangle_count; i++) {
        const size_t e = p->constraints[i];
        if (e != PBW_NONE) {
            a->sides[2 * e + (p->edges[2 * e] != p->triangles[i / 3 * 3 + (i + 1) % 3])] = p->regions[i / 3];
        }
    }
    for (i = 0; i < 2 * p->edge_count; i++) {
        edges_at[p->edges[i]] ^= i / 2;
    }
    for (i = 0; i < 2 * p->edge_count; i++) {
        if (a->stays[p->edges[i]]) {
            pbwa2__chain(a, p->edges[i], i / 2, edges_at);
        }
    }
    return 1;
}

static pbw_status pbwa2__make_again(pbwa2__remake *a, pbwa2__memory *memory, const pbw_plane_options *options,
                                    pbw_plane *result, pbw_index *from)
{
    const size_t n = a->old->point_count;
    double *points = (double *)pbwa2__zeros(memory, n, 2 * sizeof *points);
    double *sizes = a->sizes != NULL ? (double *)pbwa2__zeros(memory, n, sizeof *sizes) : NULL;
    pbw_plane_options own = *options;
    pbw_plane_input input;
    size_t i, kept = 0;
    memset(&input, 0, sizeof input);
    a->number = (pbw_index *)pbwa2__zeros(memory, n, sizeof *a->number);
    if (points == NULL || (a->sizes != NULL && sizes == NULL) || a->number == NULL) {
        return pbwa2__say(result, PBW_ERROR_MEMORY, NULL);
    }
    for (i = 0; i < n; i++) {
        if (a->stays[i]) {
            memcpy(points + 2 * kept, a->points + 2 * i, 2 * sizeof *points);
            if (sizes != NULL) {
                sizes[kept] = a->sizes[i];
            }
            if (from != NULL) {
                from[kept] = (pbw_index)i;
            }
            a->number[i] = (pbw_index)kept++;
        }
    }
    if (!pbwa2__find_segments(a, memory)) {
        return pbwa2__say(result, PBW_ERROR_MEMORY, NULL);
    }
    own.rule = PBW_PLANE_NONZERO;
    input.points = points;
    input.point_count = kept;
    input.segments = a->segments;
    input.segment_count = a->segment_count;
    input.segment_ids = a->ids;
    input.segment_lefts = a->lefts;
    input.sizes = sizes;
    return pbwa2__make(memory, &input, &own, result);
}

/* ------------------------------------------------------------------------------------------------------
   >>smoothing    Smoothing.
   In: a plane.  Out: a plane with the same number of points; points on no segment have moved.
   Holds: no move makes the least angle of the mesh smaller; each round ends with a triangulation.
   ------------------------------------------------------------------------------------------------------ */

/* The squared sine of the least angle, which has the least sine; negative: not counter-clockwise. */
static double pbwa2__sine2(const double *a, const double *b, const double *c)
{
    const double u = pbwa2__apart2(a, b), v = pbwa2__apart2(b, c), w = pbwa2__apart2(c, a);
    const double twice = pbwa2__cross(a, b, c), least = fmin(fmin(u, v), w);
    return pbw_orient2(a, b, c) > 0 ? twice * twice / (u * v * w) * least : -1;
}

static double pbwa2__star_sine2(const pbw_plane *p, const double *points, const pbwa2__stars *s, size_t v)
{
    double least = 1;
    size_t i;
    for (i = s->first[v]; i < s->first[v + 1]; i++) {
        const pbw_index *c = p->triangles + 3 * (size_t)s->item[i];
        least = fmin(least, pbwa2__sine2(pbwa2__at(points, c[0]), pbwa2__at(points, c[1]), pbwa2__at(points, c[2])));
    }
    return least;
}

/* Adds what a triangle contributes to the new place of its corner a: weight, and weight times place relative to a. */
static void pbwa2__add_move(pbw_plane_way way, const double *a, const double *b, const double *c, double sum[3])
{
    const double bx = b[0] - a[0], by = b[1] - a[1], cx = c[0] - a[0], cy = c[1] - a[1];
    const double twice = bx * cy - by * cx, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    const double x = (cy * b2 - by * c2) / (2 * twice), y = (bx * c2 - cx * b2) / (2 * twice);   /* circumcentre */
    if (way == PBW_PLANE_LAPLACE) {
        sum[0] += 2;
        sum[1] += bx + cx;
        sum[2] += by + cy;
    } else if (way == PBW_PLANE_ODT) {
        sum[0] += twice;
        sum[1] += twice * x;
        sum[2] += twice * y;
    } else {                                         /* the cell's part here: a, middle of b, centre, middle of c */
        const double one = (bx * y - by * x) / 2, other = (x * cy - y * cx) / 2;
        sum[0] += one + other;
        sum[1] += (one * (bx / 2 + x) + other * (cx / 2 + x)) / 3;
        sum[2] += (one * (by / 2 + y) + other * (cy / 2 + y)) / 3;
    }
}

/* Moves one point, or lets it stay. */
static void pbwa2__move(const pbw_plane *p, double *points, const pbwa2__stars *s, size_t v, pbw_plane_way way,
                        double bound)
{
    const double old[2] = { points[2 * v], points[2 * v + 1] };
    const double need = fmin(bound, pbwa2__star_sine2(p, points, s, v));
    double sum[3] = { 0, 0, 0 }, part;
    size_t i;
    for (i = s->first[v]; i < s->first[v + 1]; i++) {
        const pbw_index *c = p->triangles + 3 * (size_t)s->item[i];
        const unsigned k = c[0] == v ? 0u : c[1] == v ? 1u : 2u;
        pbwa2__add_move(way, old, pbwa2__at(points, c[(k + 1) % 3]), pbwa2__at(points, c[(k + 2) % 3]), sum);
    }
    for (part = 1; part > 0.1 && sum[0] > 0; part /= 2) {
        points[2 * v] = old[0] + part * sum[1] / sum[0];
        points[2 * v + 1] = old[1] + part * sum[2] / sum[0];
        if (pbwa2__star_sine2(p, points, s, v) >= need) {
            return;
        }
    }
    points[2 * v] = old[0];
    points[2 * v + 1] = old[1];
}

/* held: bytes of planes that the call holds. */
static pbw_status pbwa2__round(const pbw_plane *plane, pbw_plane_way way, const unsigned char *keep, size_t held,
                               const pbw_plane_options *options, pbw_plane *next)
{
    pbwa2__memory memory;
    pbwa2__remake a;
    pbwa2__stars stars;
    double *points, least;
    unsigned char *fixed, *stays;
    pbw_status status;
    size_t i;
    memset(&a, 0, sizeof a);
    memset(next, 0, sizeof *next);
    pbwa2__start(&memory, options);
    memory.memory.used = held;
    points = (double *)pbwa2__zeros(&memory, plane->point_count, 2 * sizeof *points);
    fixed = (unsigned char *)pbwa2__zeros(&memory, plane->point_count, 1);
    stays = (unsigned char *)pbwa2__zeros(&memory, plane->point_count, 1);
    if (points == NULL || fixed == NULL || stays == NULL || !pbwa2__find_stars(&memory, plane, &stars)) {
        pbwa2__end(&memory);
        return pbwa2__say(next, PBW_ERROR_MEMORY, NULL);
    }
    memcpy(points, plane->points, 2 * plane->point_count * sizeof *points);
    memset(stays, 1, plane->point_count);
    for (i = 0; i < 2 * plane->edge_count; i++) {
        fixed[plane->edges[i]] = 1;
    }
    least = sin(pbw_plane_quality_of(plane, PBW_PLANE_MIN_ANGLE).least / PBWA2__DEGREES);
    for (i = 0; i < plane->point_count && !pbwa2__step(options, i, plane->point_count); i++) {
        if (!fixed[i] && !(keep != NULL && keep[i]) && stars.first[i] < stars.first[i + 1]) {
            pbwa2__move(plane, points, &stars, i, way, fmax(least * least, 0.25));
        }
    }
    a.old = plane;
    a.points = points;
    a.stays = stays;
    status = i < plane->point_count ? pbwa2__say(next, PBW_CANCELLED, NULL)
           : pbwa2__make_again(&a, &memory, options, next, NULL);
    pbwa2__end(&memory);
    return status;
}

PBWDEF pbw_status pbw_plane_smooth(pbw_plane *plane, pbw_plane_way way, int rounds, const unsigned char *keep,
                                   const pbw_plane_options *options)
{
    pbw_plane_options own;
    pbw_plane now, next;
    int i;
    memset(&own, 0, sizeof own);
    if (plane == NULL || (unsigned)way > PBW_PLANE_ODT) {
        return PBW_ERROR_ARGUMENT;
    }
    own.build = options != NULL ? options->build : NULL;
    now = *plane;
    for (i = 0; i < rounds && now.triangle_count > 0; i++) {
        const pbw_status status = pbwa2__round(&now, way, keep, i > 0 ? now.bytes : 0, &own, &next);
        if (i > 0) {
            pbw_plane_free(&now);
        }
        if (status != PBW_OK) {
            memcpy(plane->what, next.what, sizeof plane->what);
            pbw_plane_free(&next);
            return status;
        }
        now = next;
    }
    if (i > 0) {
        now.input_count = plane->input_count;
        now.report = plane->report;
        pbw_plane_free(plane);
        *plane = now;
    }
    return PBW_OK;
}

/* ------------------------------------------------------------------------------------------------------
   >>sizes        Sizes.
   In: errors of triangles, or sizes at points.  Out: sizes at points; they grow from point to point by a bound.
   ------------------------------------------------------------------------------------------------------ */

/* A triangle with error e that is cut into m parts has m triangles of error e / m each, as the error falls with the
   square of the size.  For one error c of all, m = e / c, and c = sum of e / count.  The mean triangle of a mesh with
   no edge longer than h has about the area of an equilateral one with edges 0.6 h. */
PBWDEF void pbw_plane_sizes(const pbw_plane *plane, const double *error, size_t count, double *sizes)
{
    double sum = 0;
    size_t i;
    unsigned k;
    for (i = 0; i < plane->triangle_count; i++) {
        sum += error[i];
    }
    for (i = 0; i < plane->point_count; i++) {
        sizes[i] = 0;
    }
    for (i = 0; i < plane->triangle_count; i++) {
        const pbw_index *v = plane->triangles + 3 * i;
        const double twice = pbwa2__cross(pbwa2__at(plane->points, v[0]), pbwa2__at(plane->points, v[1]),
                                          pbwa2__at(plane->points, v[2]));
        const double parts = fmin(16, fmax(1 / 16.0, error[i] * (double)count / sum));
        const double size = sqrt(2 * twice / PBWA2__SQRT3 / parts) / 0.6;
        for (k = 0; k < 3; k++) {
            sizes[v[k]] = sizes[v[k]] > 0 ? fmin(sizes[v[k]], size) : size;
        }
    }
}

/* Sizes grow from point to point by at most `growth` times the distance. */
static void pbwa2__grade(const pbw_plane *p, double growth, double *sizes)
{
    size_t i;
    unsigned k;
    int more = 1;
    while (more) {
        more = 0;
        for (i = 0; i < 6 * p->triangle_count; i++) {
            const pbw_index *c = p->triangles + 3 * (i / 6);
            pbw_index u, v;
            double most;
            k = (unsigned)(i % 3);
            u = c[k];
            v = c[(k + 1 + (i / 3 & 1)) % 3];
            most = sizes[u] + growth * sqrt(pbwa2__apart2(pbwa2__at(p->points, u), pbwa2__at(p->points, v)));
            if (most < sizes[v]) {
                sizes[v] = most;
                more = 1;
            }
        }
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>coarsening   Which points stay, and adaptation.
   In: sizes.  Out: stays.
   Holds: of two points that stay, if one could be removed and edges connect them nearby, the distance is at least
   half of the smaller of their sizes.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWA2__FREE, PBWA2__INNER, PBWA2__END };      /* of no segment; inside of one; the rest */

typedef struct pbwa2__coarsening {
    const pbw_plane *p;
    pbwa2__stars stars;
    const double *sizes;
    unsigned char *kind, *stays;
    pbw_index *list, *seen;                          /* seen: the last point that looked at a point, plus 1 */
} pbwa2__coarsening;

static int pbwa2__same_ids(const pbw_plane *p, size_t e, size_t f)
{
    const size_t n = pbwa2__id_count(p, e);
    return n == pbwa2__id_count(p, f)
        && (n == 0 || memcmp(p->edge_segments + p->edge_first[e], p->edge_segments + p->edge_first[f],
                             n * sizeof *p->edge_segments) == 0);
}

/* Returns whether v is between u and w up to 8 ulps of the coordinates: refinement rounds points on segments by one.
   */
static int pbwa2__is_straight(const double *u, const double *v, const double *w)
{
    const double most = fmax(fmax(fmax(fabs(u[0]), fabs(u[1])), fmax(fabs(w[0]), fabs(w[1]))),
                             fmax(fabs(v[0]), fabs(v[1])));
    const double off = most * 8 * 2.2204460492503131e-16, cross = pbwa2__cross(u, v, w);
    const double dot = (u[0] - v[0]) * (w[0] - v[0]) + (u[1] - v[1]) * (w[1] - v[1]);
    return dot < 0 && cross * cross <= off * off * pbwa2__apart2(u, w);
}

/* The end of edge e that is not v. */
static const double *pbwa2__other_end(const pbw_plane *p, size_t e, pbw_index v)
{
    return pbwa2__at(p->points, p->edges[2 * e] == v ? p->edges[2 * e + 1] : p->edges[2 * e]);
}

/* Finds the kinds of points: a point inside a segment has two collinear edges, with the same segments and sides. */
static int pbwa2__find_kinds(pbwa2__coarsening *t, pbwa2__memory *memory, const unsigned char *keep)
{
    const pbw_plane *p = t->p;
    size_t *one = (size_t *)pbwa2__zeros(memory, p->point_count, sizeof *one);
    unsigned char *inside = (unsigned char *)pbwa2__zeros(memory, p->edge_count, 1);
    unsigned char *degree = (unsigned char *)pbwa2__zeros(memory, p->point_count, 1);
    size_t i;
    if (one == NULL || inside == NULL || degree == NULL) {
        return 0;
    }
    for (i = 0; i < 3 * p->triangle_count; i++) {
        if (p->constraints[i] != PBW_NONE) {
            inside[p->constraints[i]] |= p->neighbors[i] != PBW_NONE;
        }
    }
    for (i = 0; i < 2 * p->edge_count; i++) {
        const pbw_index v = p->edges[i];
        const size_t e = i / 2;
        const int goes_on = degree[v] == 1 && inside[e] == inside[one[v]] && pbwa2__same_ids(p, e, one[v])
            && pbwa2__is_straight(pbwa2__other_end(p, e, v), pbwa2__at(p->points, v),
                                  pbwa2__other_end(p, one[v], v));
        t->kind[v] = goes_on ? PBWA2__INNER : PBWA2__END;
        one[v] = e;
        degree[v] = (unsigned char)(degree[v] < 3 ? degree[v] + 1 : 3);
    }
    for (i = 0; i < p->point_count; i++) {
        if ((keep != NULL && keep[i]) || t->stars.first[i] == t->stars.first[i + 1]) {
            t->kind[i] = PBWA2__END;
        }
    }
    return 1;
}

/* Returns whether a point that stays is close to v. */
static int pbwa2__is_crowded(pbwa2__coarsening *t, pbw_index v)
{
    const double *here = pbwa2__at(t->p->points, v);
    size_t count = 1, at, i;
    unsigned k;
    t->list[0] = v;
    t->seen[v] = v + 1;
    for (at = 0; at < count; at++) {
        for (i = t->stars.first[t->list[at]]; i < t->stars.first[t->list[at] + 1]; i++) {
            for (k = 0; k < 3; k++) {
                const pbw_index w = t->p->triangles[3 * (size_t)t->stars.item[i] + k];
                const double apart2 = 4 * pbwa2__apart2(here, pbwa2__at(t->p->points, w));
                if (t->seen[w] == v + 1 || !(apart2 < t->sizes[v] * t->sizes[v])) {
                    continue;
                }
                if (t->stays[w] && apart2 < t->sizes[w] * t->sizes[w]) {
                    return 1;
                }
                t->seen[w] = v + 1;
                t->list[count++] = w;
            }
        }
    }
    return 0;
}

static void pbwa2__coarsen(pbwa2__coarsening *t)
{
    int kind;
    size_t i;
    for (kind = PBWA2__END; kind >= PBWA2__FREE; kind--) {
        for (i = 0; i < t->p->point_count; i++) {
            if (t->kind[i] == kind) {
                t->stays[i] = kind == PBWA2__END || !pbwa2__is_crowded(t, (pbw_index)i);
            }
        }
    }
}

PBWDEF pbw_status pbw_plane_adapt(const pbw_plane *plane, const double *sizes, const unsigned char *keep,
                                  const pbw_plane_options *options, pbw_plane *result, pbw_index *from)
{
    pbwa2__memory memory;
    pbwa2__remake a;
    pbwa2__coarsening t;
    pbw_plane_options own;
    pbw_status status = PBW_ERROR_MEMORY;
    double *graded;
    size_t i, n;
    if (result == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(result, 0, sizeof *result);
    memset(&a, 0, sizeof a);
    memset(&t, 0, sizeof t);
    memset(&own, 0, sizeof own);
    own = options != NULL ? *options : own;
    if (plane == NULL || sizes == NULL || plane->triangle_count == 0 || !(own.gradation >= 0)) {
        return pbwa2__say(result, PBW_ERROR_ARGUMENT, "a mesh with triangles and sizes are needed");
    }
    own.flags |= PBW_PLANE_REFINE;
    n = plane->point_count;
    pbwa2__start(&memory, options);
    graded = (double *)pbwa2__zeros(&memory, n, sizeof *graded);
    t.kind = (unsigned char *)pbwa2__zeros(&memory, n, 1);
    t.stays = (unsigned char *)pbwa2__zeros(&memory, n, 1);
    t.list = (pbw_index *)pbwa2__zeros(&memory, n, sizeof *t.list);
    t.seen = (pbw_index *)pbwa2__zeros(&memory, n, sizeof *t.seen);
    t.p = a.old = plane;
    t.sizes = a.sizes = graded;
    a.points = plane->points;
    a.stays = t.stays;
    if (graded != NULL && t.kind != NULL && t.stays != NULL && t.list != NULL && t.seen != NULL
        && pbwa2__find_stars(&memory, plane, &t.stars) && pbwa2__find_kinds(&t, &memory, keep)) {
        for (i = 0; i < n; i++) {
            graded[i] = sizes[i] > 0 ? sizes[i] : 1e60;
        }
        pbwa2__grade(plane, own.gradation > 0 ? own.gradation : 0.3, graded);
        pbwa2__coarsen(&t);
        status = pbwa2__make_again(&a, &memory, &own, result, from);
    } else {
        status = pbwa2__say(result, status, NULL);
    }
    pbwa2__end(&memory);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>triangles    A plane from triangles.
   In: triangles, their regions, segments.
   Out: the plane of the sides that stay and of the segments.  A side turns as its triangle does, so the domain is
   what the sides wind round; segments go there and back, and add up to 0.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwa2__side { pbw_index low, high, u, v, region; } pbwa2__side;      /* its triangle is left of u-v */
typedef struct pbwa2__place { double x, y; pbw_index number; } pbwa2__place;

static int pbwa2__compare(const void *one, const void *other)
{
    const pbwa2__side *a = (const pbwa2__side *)one, *b = (const pbwa2__side *)other;
    return a->low != b->low ? (a->low < b->low ? -1 : 1) : a->high != b->high ? (a->high < b->high ? -1 : 1) : 0;
}

static int pbwa2__compare_places(const void *one, const void *other)
{
    const pbwa2__place *a = (const pbwa2__place *)one, *b = (const pbwa2__place *)other;
    return a->x < b->x || a->x > b->x ? (a->x < b->x ? -1 : 1) : a->y < b->y || a->y > b->y ? (a->y < b->y ? -1 : 1)
         : (a->number > b->number) - (a->number < b->number);
}

/* Fills sides.  Returns 0 and says why if a triangle is none. */
static int pbwa2__find_sides(const pbw_plane_input *input, const pbw_index *triangles, const pbw_index *regions,
                             size_t count, pbwa2__side *side, pbw_plane *plane)
{
    const size_t n = input->point_count;
    size_t i;
    unsigned k;
    for (i = 0; i < count; i++) {
        const pbw_index *c = triangles + 3 * i;
        const int there = c[0] < n && c[1] < n && c[2] < n;
        const int turn = there ? pbw_orient2(pbwa2__at(input->points, c[0]), pbwa2__at(input->points, c[1]),
                                             pbwa2__at(input->points, c[2])) : 0;
        if (turn == 0) {
            const double *a = there ? pbwa2__at(input->points, c[0]) : NULL;
            if (there) {
                snprintf(plane->what, sizeof plane->what, "triangle %lu at (%.9g, %.9g) is flat", (unsigned long)i,
                         a[0], a[1]);
            } else {
                snprintf(plane->what, sizeof plane->what, "triangle %lu has a corner that is not there",
                         (unsigned long)i);
            }
            return 0;
        }
        for (k = 0; k < 3; k++, side++) {
            side->u = c[turn > 0 ? k : (k + 1) % 3];
            side->v = c[turn > 0 ? (k + 1) % 3 : k];
            side->region = regions != NULL ? regions[i] : PBW_NONE;
        }
    }
    return 1;
}

/* Gives sides the first of the corners at a place; each corner is u of one side.  Returns 0 without memory. */
static int pbwa2__unite_points(pbwa2__memory *memory, const double *points, size_t n, pbwa2__side *side, size_t count)
{
    pbwa2__place *place = (pbwa2__place *)pbwa2__zeros(memory, count, sizeof *place);
    pbw_index *first = (pbw_index *)pbwa2__zeros(memory, n, sizeof *first);
    size_t i, k = 0;
    if (place == NULL || first == NULL) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        place[i].x = pbwa2__at(points, side[i].u)[0];
        place[i].y = pbwa2__at(points, side[i].u)[1];
        place[i].number = side[i].u;
    }
    qsort(place, count, sizeof *place, pbwa2__compare_places);
    for (i = 0; i < count; i++) {
        k = place[i].x > place[k].x || place[i].y > place[k].y || place[i].y < place[k].y ? i : k;
        first[place[i].number] = place[k].number;
    }
    for (i = 0; i < count; i++) {
        side[i].u = first[side[i].u];
        side[i].v = first[side[i].v];
    }
    return 1;
}

/* Keeps the sides of edges with one triangle, and of those between regions.  *shared: how many edges have two
   triangles.  Returns the number of sides, or SIZE_MAX and says where an edge has two triangles on one side. */
static size_t pbwa2__find_border(const double *points, pbwa2__side *side, size_t count, size_t *shared,
                                 pbw_plane *plane)
{
    size_t i, kept = 0;
    *shared = 0;
    for (i = 0; i < count; i++) {
        side[i].low = side[i].u < side[i].v ? side[i].u : side[i].v;
        side[i].high = side[i].u < side[i].v ? side[i].v : side[i].u;
    }
    qsort(side, count, sizeof *side, pbwa2__compare);
    for (i = 0; i < count; i++) {
        if (i + 1 == count || pbwa2__compare(side + i, side + i + 1) != 0) {
            side[kept++] = side[i];
        } else if (side[i].u == side[i + 1].u || (i + 2 < count && pbwa2__compare(side + i, side + i + 2) == 0)) {
            const double *u = pbwa2__at(points, side[i].u), *v = pbwa2__at(points, side[i].v);
            snprintf(plane->what, sizeof plane->what, "two triangles are on one side of the edge from (%.9g, %.9g) "
                     "to (%.9g, %.9g)", u[0], u[1], v[0], v[1]);
            return SIZE_MAX;
        } else {
            ++*shared;
            if (side[i].region != side[i + 1].region) {
                side[kept++] = side[i];
                side[kept++] = side[i + 1];
            }
            i++;
        }
    }
    return kept;
}

/* About where two segments cross. */
static void pbwa2__find_crossing(const double *points, const pbw_index *s, const pbw_index *t, double out[2])
{
    const double *a = pbwa2__at(points, s[0]), *b = pbwa2__at(points, s[1]);
    const double *u = pbwa2__at(points, t[0]), *v = pbwa2__at(points, t[1]);
    const double here = pbwa2__cross(u, v, a), share = here / (here - pbwa2__cross(u, v, b));
    out[0] = a[0] + share * (b[0] - a[0]);
    out[1] = a[1] + share * (b[1] - a[1]);
}

/* Makes the plane of the segments, the sides, and the segments the other way. */
static pbw_status pbwa2__make_of_sides(pbwa2__memory *memory, const pbw_plane_input *given, const pbwa2__side *side,
                                       size_t count, const pbw_plane_options *options, pbw_plane *plane)
{
    const size_t n = given->segment_count, all = count + 2 * n;
    pbw_index *segments = (pbw_index *)pbwa2__zeros(memory, all, 2 * sizeof *segments);
    pbw_index *ids = (pbw_index *)pbwa2__zeros(memory, all, sizeof *ids);
    pbw_index *lefts = (pbw_index *)pbwa2__zeros(memory, all, sizeof *lefts);
    pbw_plane_options own = *options;
    pbw_plane_input input;
    pbw_status status;
    size_t i;
    if (segments == NULL || ids == NULL || lefts == NULL) {
        return pbwa2__say(plane, PBW_ERROR_MEMORY, NULL);
    }
    memset(ids, 255, all * sizeof *ids);
    memset(lefts, 255, all * sizeof *lefts);
    for (i = 0; i < n; i++) {
        segments[2 * i] = segments[2 * (n + count + i) + 1] = given->segments[2 * i];
        segments[2 * i + 1] = segments[2 * (n + count + i)] = given->segments[2 * i + 1];
        ids[i] = given->segment_ids != NULL ? given->segment_ids[i] : (pbw_index)i;
    }
    for (i = 0; i < count; i++) {
        segments[2 * (n + i)] = side[i].u;
        segments[2 * (n + i) + 1] = side[i].v;
        lefts[n + i] = side[i].region;
    }
    memset(&input, 0, sizeof input);
    input.points = given->points;
    input.point_count = given->point_count;
    input.sizes = given->sizes;
    input.segments = segments;
    input.segment_ids = ids;
    input.segment_lefts = lefts;
    input.segment_count = all;
    own.rule = PBW_PLANE_NONZERO;
    status = pbwa2__make(memory, &input, &own, plane);
    if (status == PBW_ERROR_ARGUMENT && plane->crossing_count > 0) {         /* once more, with numbers of all */
        double at[2] = { 0, 0 };
        pbw_plane_free(plane);
        input.segment_ids = NULL;
        status = pbwa2__make(memory, &input, &own, plane);
        if (status == PBW_ERROR_ARGUMENT && plane->crossing_count > 0) {
            const pbw_index *s = segments + 2 * (size_t)plane->crossings[0];
            const pbw_index *t = segments + 2 * (size_t)plane->crossings[1];
            pbwa2__find_crossing(given->points, s, t, at);
            pbw_plane_free(plane);
            snprintf(plane->what, sizeof plane->what, "borders of triangles, or segments, cross at (%.9g, %.9g): "
                     "triangles lie on each other, or a segment is no edge of one", at[0], at[1]);
        }
    }
    return status;
}

PBWDEF pbw_status pbw_plane_from_triangles(const pbw_plane_input *input, const pbw_index *triangles,
                                           const pbw_index *regions, size_t triangle_count,
                                           const pbw_plane_options *options, pbw_plane *plane)
{
    pbwa2__memory memory;
    pbwa2__side *side;
    pbw_plane_options own;
    pbw_status status;
    size_t count = 0, shared = 0;
    if (plane == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(plane, 0, sizeof *plane);
    memset(&own, 0, sizeof own);
    own = options != NULL ? *options : own;
    if (input == NULL || input->points == NULL || triangles == NULL || triangle_count == 0
        || (input->segments == NULL && input->segment_count > 0)) {
        return pbwa2__say(plane, PBW_ERROR_ARGUMENT, "points and triangles are needed, or an array is NULL");
    }
    pbwa2__start(&memory, options);
    side = (pbwa2__side *)pbwa2__zeros(&memory, 3 * triangle_count, sizeof *side);
    status = side == NULL ? pbwa2__say(plane, PBW_ERROR_MEMORY, NULL)
           : pbwa2__find_sides(input, triangles, regions, triangle_count, side, plane) ? PBW_OK : PBW_ERROR_ARGUMENT;
    if (status == PBW_OK) {
        count = pbwa2__find_border(input->points, side, 3 * triangle_count, &shared, plane);
    }
    if (status == PBW_OK && shared == 0 && count != SIZE_MAX && triangle_count > 1) {
        if (pbwa2__unite_points(&memory, input->points, input->point_count, side, count)) {
            count = pbwa2__find_border(input->points, side, count, &shared, plane);
        } else {
            status = pbwa2__say(plane, PBW_ERROR_MEMORY, NULL);
        }
    }
    if (status == PBW_OK) {
        status = count == SIZE_MAX ? PBW_ERROR_ARGUMENT
               : pbwa2__make_of_sides(&memory, input, side, count, &own, plane);
    }
    pbwa2__end(&memory);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>transfer     Values at the points of another mesh.
   The nearest triangle of each point is found by a tree of boxes over runs of 4^k triangles, which pbw_plane has in
   the order of a curve.
   In: values at the points of one plane.  Out: those at the points of another.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwa2__box { double low[2], high[2]; } pbwa2__box;

typedef struct pbwa2__tree {
    const pbw_plane *p;
    pbwa2__box *box;
    size_t first[34], count[34];           /* of each level; level 0: boxes of triangles */
    int levels;
} pbwa2__tree;

static int pbwa2__build_tree(pbwa2__tree *tree, pbwa2__memory *memory)
{
    const pbw_plane *p = tree->p;
    size_t count = p->triangle_count, total = 0, i, j;
    int level, k;
    for (tree->levels = 0; tree->levels == 0 || tree->count[tree->levels - 1] > 1; tree->levels++) {
        tree->first[tree->levels] = total;
        tree->count[tree->levels] = count;
        total += count;
        count = (count + 3) / 4;
    }
    tree->box = (pbwa2__box *)pbwa2__zeros(memory, total, sizeof *tree->box);
    if (tree->box == NULL) {
        return 0;
    }
    for (level = 0; level < tree->levels; level++) {
        for (i = 0; i < tree->count[level]; i++) {
            pbwa2__box *box = tree->box + tree->first[level] + i;
            const size_t below = level == 0 ? 3 : tree->count[level - 1] - 4 * i, parts = below < 4 ? below : 4;
            for (k = 0; k < 2; k++) {
                box->low[k] = HUGE_VAL;
                box->high[k] = -HUGE_VAL;
                for (j = 0; j < parts; j++) {
                    const pbwa2__box *part = level > 0 ? tree->box + tree->first[level - 1] + 4 * i + j : NULL;
                    const double *at = pbwa2__at(p->points, p->triangles[level > 0 ? 0 : 3 * i + j]);
                    box->low[k] = fmin(box->low[k], part != NULL ? part->low[k] : at[k]);
                    box->high[k] = fmax(box->high[k], part != NULL ? part->high[k] : at[k]);
                }
            }
        }
    }
    return 1;
}

/* The squared distance of q from a triangle, and the weights of its corners at the nearest place. */
static double pbwa2__distance2_to(const pbw_plane *p, size_t triangle, const double *q, double weight[3])
{
    const pbw_index *v = p->triangles + 3 * triangle;
    double sum = 0, best = HUGE_VAL;
    unsigned k;
    for (k = 0; k < 3; k++) {
        weight[k] = pbwa2__cross(q, pbwa2__at(p->points, v[(k + 1) % 3]), pbwa2__at(p->points, v[(k + 2) % 3]));
        sum += weight[k];
    }
    if (weight[0] >= 0 && weight[1] >= 0 && weight[2] >= 0 && sum > 0) {
        for (k = 0; k < 3; k++) {
            weight[k] /= sum;
        }
        return 0;
    }
    for (k = 0; k < 3; k++) {
        const double *a = pbwa2__at(p->points, v[(k + 1) % 3]), *b = pbwa2__at(p->points, v[(k + 2) % 3]);
        const double x = b[0] - a[0], y = b[1] - a[1];
        const double along = ((q[0] - a[0]) * x + (q[1] - a[1]) * y) / (x * x + y * y);
        const double t = along > 0 ? fmin(along, 1) : 0;
        const double at[2] = { a[0] + t * x, a[1] + t * y };
        const double apart2 = pbwa2__apart2(q, at);
        if (apart2 < best) {
            best = apart2;
            weight[k] = 0;
            weight[(k + 1) % 3] = 1 - t;
            weight[(k + 2) % 3] = t;
        }
    }
    return best;
}

static double pbwa2__box_apart2(const pbwa2__box *box, const double *q)
{
    const double x = fmax(0, fmax(box->low[0] - q[0], q[0] - box->high[0]));
    const double y = fmax(0, fmax(box->low[1] - q[1], q[1] - box->high[1]));
    return x * x + y * y;
}

/* Returns the triangle nearest to q, the first of several; begins with `guess`. */
static size_t pbwa2__nearest(const pbwa2__tree *tree, const double *q, size_t guess, double weight[3])
{
    size_t stack[4 * 34], found = guess, n = 0;
    double best = pbwa2__distance2_to(tree->p, guess, q, weight), other[3];
    stack[n++] = (size_t)(tree->levels - 1);         /* level, + 64 times the number in the level */
    while (n > 0 && best > 0) {
        const size_t level = stack[--n] & 63, at = stack[n] >> 6;
        size_t j;
        if (pbwa2__box_apart2(tree->box + tree->first[level] + at, q) >= best) {
            continue;
        }
        if (level == 0) {
            const double apart2 = pbwa2__distance2_to(tree->p, at, q, other);
            if (apart2 < best) {
                best = apart2;
                found = at;
                memcpy(weight, other, sizeof other);
            }
            continue;
        }
        for (j = 4; j-- > 0; ) {
            if (4 * at + j < tree->count[level - 1]) {
                stack[n++] = (level - 1) | (4 * at + j) << 6;
            }
        }
    }
    return found;
}

/* The weighted mean of three values, rounded to one between them: a constant stays one. */
static double pbwa2__mean_of(const double weight[3], double a, double b, double c)
{
    const double mean = weight[0] * a + weight[1] * b + weight[2] * c;
    const double low = a < b ? (a < c ? a : c) : b < c ? b : c, high = a > b ? (a > c ? a : c) : b > c ? b : c;
    return mean < low ? low : mean > high ? high : mean;
}

PBWDEF pbw_status pbw_plane_transfer(const pbw_plane *from, const pbw_plane *to, const double *values,
                                     size_t width, double *out, const pbw_plane_options *options)
{
    pbwa2__memory memory;
    pbwa2__tree tree;
    double weight[3];
    size_t i, k, at = 0;
    if (from == NULL || to == NULL || values == NULL || out == NULL || from->triangle_count == 0) {
        return PBW_ERROR_ARGUMENT;
    }
    pbwa2__start(&memory, options);
    memset(&tree, 0, sizeof tree);
    tree.p = from;
    if (!pbwa2__build_tree(&tree, &memory)) {
        pbwa2__end(&memory);
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < to->point_count && !pbwa2__step(options, i, to->point_count); i++) {
        const pbw_index *v;
        at = pbwa2__nearest(&tree, to->points + 2 * i, at, weight);
        v = from->triangles + 3 * at;
        for (k = 0; k < width; k++) {
            out[width * i + k] = pbwa2__mean_of(weight, values[width * v[0] + k], values[width * v[1] + k],
                                                values[width * v[2] + k]);
        }
    }
    pbwa2__end(&memory);
    return i == to->point_count ? PBW_OK : PBW_CANCELLED;
}

PBW_CONTRACTION_ON
#endif /* PBW_ADAPT2_IMPLEMENTATION */
