/* pbw_mesh2.h - v0.2.0 - plane domains: constraints, holes, regions, refinement - MIT-0

   QUICK START
   In one source file, define PBW_MESH2_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file.

       const double points[] = { 0,0, 4,0, 4,3, 0,3,  1,1, 2,1, 2,2, 1,2 };      // a plate, a hole
       const pbw_index segments[] = { 0,1, 1,2, 2,3, 3,0,  4,5, 5,6, 6,7, 7,4 };
       pbw_plane_input input = {0};
       pbw_plane_options options = {0};
       pbw_plane plane = {0};
       input.points = points;
       input.point_count = 8;
       input.segments = segments;
       input.segment_count = 8;
       options.rule = PBW_PLANE_EVEN_ODD;
       options.flags = PBW_PLANE_REFINE;                             // no angle below 30 degrees
       if (pbw_plane_make(&input, &options, &plane) != PBW_OK) puts(plane.what);
       printf("%u triangles\n", (unsigned)plane.triangle_count);
       pbw_plane_free(&plane);

   FUNCTIONS
     pbw_plane_make   triangulates and refines a domain
     pbw_plane_rings  triangulates polygons with holes
     pbw_plane_free   frees a plane

   HOW
   Segments are inserted into the Delaunay triangulation of the points one by one: the triangles that a segment
   crosses are replaced on both sides of it.  The tie rule of pbw.h makes the result unique: the constrained
   triangulation of the set of points and segments, whatever their order.  Refinement moves its own points or inserts
   more where an angle or a size is not as wanted, and splits segments that such points come close to.

   PROMISES  (tests/test_mesh2.c guards them)
     exact       no tolerance decides which triangles there are; segments are never moved to fit
     one answer  the same triangles for every order of points, segments and their ends, and for any number of threads
     whole       every segment is a chain of edges, and each such edge lists its segments
     bounded     every call ends: refinement makes no edge shorter than 1e-10 of the domain; no recursion

   A point of refinement on a segment is rounded to doubles, so it lies at most an ulp of the coordinates beside the
   segment.  The two parts of the segment are then the constraints.

   LIMITS
     A segment that crosses n edges takes time n^2 at worst, n log n as a rule.  Refinement needs coordinates of at
     most 1e60, in a domain of at least 1e-60.  One thread, but for the triangulation of the points.

   CONTENTS
     >>interface    types and functions
     >>memory       growing arrays
     >>job          a call, and its triangles
     >>signs        orientation, circles
     >>segments     segments inserted into a triangulation
     >>crossings    segments that cross, and are cut there
     >>domain       winding numbers, holes, regions
     >>refinement   what is wrong with a triangle; queues; cavities
     >>steps        splits of segments, moves and insertions of points
     >>loop         all steps, until nothing is wrong
     >>result       the caller's arrays
     >>calls        the public functions

   CONFIGURATION MACROS
     PBW_MESH2_IMPLEMENTATION    in one source file: compile the implementation there
*/
#ifndef PBW_MESH2_H
#define PBW_MESH2_H
#ifndef PBW_H
#include "pbw.h"
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */

#ifdef __cplusplus
extern "C" {
#endif

/* ---- in */

typedef enum pbw_plane_rule {              /* which triangles belong to the domain */
    PBW_PLANE_HULL = 0,                    /* all, but holes */
    PBW_PLANE_SEEDS,                       /* what segments enclose, but holes: the rule of Triangle */
    PBW_PLANE_EVEN_ODD,                    /* where the winding number of the segments is odd; but holes */
    PBW_PLANE_NONZERO                      /* where it is not 0; but holes */
} pbw_plane_rule;

typedef struct pbw_plane_region {          /* the triangles that a point can reach without crossing a segment */
    double x, y;                           /* the point */
    double area;                           /* most area of a triangle there; 0 = no bound of its own */
} pbw_plane_region;

typedef struct pbw_plane_input {           /* start from {0} */
    const double *points;                  /* x and y each; all of them become vertices */
    size_t point_count;
    const pbw_index *segments;             /* two points each */
    size_t segment_count;
    const pbw_index *segment_ids;          /* numbers of segments in what comes out, several may have one; PBW_NONE:
                                              the segment is in no list of an edge; NULL: 0, 1, 2, ... */
    const pbw_index *segment_lefts;        /* numbers, for region_seeds, of the regions to the left of segments;
                                              PBW_NONE: none.  An edge of segments without numbers lies in one
                                              region.  Of several for a region the least counts, if none of `regions`
                                              marks it.  NULL */
    const double *holes;                   /* x and y each: what such a point can reach is no part of the domain */
    size_t hole_count;
    const pbw_plane_region *regions;       /* of two for one region the last counts */
    size_t region_count;
    const double *sizes;                   /* for refinement: wanted length of edges at each point, 0 = any; linear
                                              in between; NULL */
} pbw_plane_input;

#define PBW_PLANE_SPLIT_CROSSINGS 1u       /* segments that cross: put in the crossing, rounded to the doubles of the
                                              largest coordinate, and go on until none cross, at most 16 rounds; from
                                              the second on a crossing 1, 2, 4, ... ulps from an end is put there.
                                              Without the flag crossings are PBW_ERROR_ARGUMENT, listed in
                                              plane.crossings */
#define PBW_PLANE_REFINE          2u       /* angles and sizes as wanted; else the constrained triangulation alone */
#define PBW_PLANE_KEEP_BOUNDARY   4u       /* refinement puts no point on the boundary of the domain */
#define PBW_PLANE_KEEP_SEGMENTS   8u       /* nor on any other segment */
#define PBW_PLANE_CONFORMING     16u       /* all triangles Delaunay, across segments too: more points */

typedef struct pbw_plane_options {         /* NULL or all zero = best defaults */
    unsigned flags;                        /* PBW_PLANE_SPLIT_CROSSINGS and so on, or'ed */
    pbw_plane_rule rule;
    double angle;                          /* least angle in degrees, up to 34; 0 = 30; below 0 = any */
    double area, size;                     /* most area of a triangle, most length of an edge; 0 = no bound */
    double (*size_at)(void *user, double x, double y);    /* most length of an edge about there; 0 = no bound */
    void  *size_user;
    double gradation;                      /* most growth of sizes per distance inside the domain, to a twentieth: of
                                              those of points, and if it is above 0 of size_at and of the areas of
                                              regions too; 0 = 0.3 */
    size_t steiner_limit;                  /* most points that refinement inserts, 0 = no limit but memory */
    double most;                           /* triangles of refinement; 0 = 50 million.  Sizes that ask for more are
                                              PBW_ERROR_TOO_LARGE before work, as is refinement once it has more */
    const pbw_options *build;              /* threads, memory_limit, resize, progress, as in pbw.h; NULL = defaults.
                                              Stages: those of pbw_triangulate for the points; PBW_STAGE_WORK for
                                              segments and refinement, PBW_STAGE_CHECK for the counts of the report,
                                              PBW_STAGE_OUTPUT for the arrays */
} pbw_plane_options;

/* ---- out */

typedef struct pbw_plane_report {
    size_t steiner_count;                  /* points that refinement has left in the mesh */
    size_t removed;                        /* and that it has taken out again */
    size_t small_angles;                   /* triangles with a smaller angle than wanted: at small angles of the
                                              input, or left so by the limits below */
    size_t too_large;                      /* triangles larger than wanted, for the same reasons */
    size_t short_edges;                    /* refused splits: the edges would be too short for the coordinates */
    int limited;                           /* 1: steiner_limit ended the refinement */
    int rounds;                            /* of splitting crossings */
    double estimate;                       /* triangles that refinement was to have, from sizes; if that or their
                                              number was above options.most, what was */
} pbw_plane_report;

typedef struct pbw_plane {                 /* start from {0}; read, do not write; pbw_plane_free when done */
    size_t point_count, input_count;       /* the caller's points come first, with their numbers; then crossings, then
                                              points of refinement */
    size_t triangle_count;
    const double *points;
    const pbw_index *triangles;            /* three corners each, counter-clockwise */
    const pbw_index *neighbors;            /* entry i is across from corner i; PBW_NONE = outside of the domain */
    const pbw_index *constraints;          /* per corner: the edge of segments opposite to it; PBW_NONE = none */
    const pbw_index *regions;              /* per triangle: its region, which segments separate from others */
    size_t edge_count;                     /* edges of segments that the domain has, and its boundary */
    const pbw_index *edges;                /* two points each */
    const size_t *edge_first;              /* edge_count + 1: the segments of edge i are */
    const pbw_index *edge_segments;        /* edge_first[i] .. edge_first[i+1]-1, ascending; none: of the hull, or of
                                              segments without numbers */
    size_t region_count;
    const int *region_windings;            /* per region: winding number of the segments, where the rule needs it */
    const pbw_index *region_seeds;         /* per region: the number of the caller's region, or of segment_lefts, or
                                              PBW_NONE */
    size_t crossing_count;
    const pbw_index *crossings;            /* pairs of segments that cross, ascending */
    pbw_plane_report report;
    char what[160];                        /* why a call failed, "" if it did not */
    size_t bytes;                          /* that it holds, through options.build->resize */
    void *memory;                          /* private */
} pbw_plane;

/* Triangulates a domain.  Segments without length are ignored; overlapping ones have edges in common.  A segment
   through a point is split there.  PBW_DEGENERATE: all points are on one line, and there are no triangles.  Otherwise
   fails as pbw_triangulate does; PBW_ERROR_ARGUMENT also for segments with ids out of range, segments that cross, and
   segments that are not closed although the rule counts windings; PBW_ERROR_TOO_LARGE also for more triangles than
   options.most.  After a failure, plane has only what, crossings and report.estimate. */
PBWDEF pbw_status pbw_plane_make(const pbw_plane_input *input, const pbw_plane_options *options, pbw_plane *plane);
/* Triangulates polygons with holes: closed rings of points in any direction, ring i being points first[i] ..
   first[i+1]-1.  Uses options->rule, where PBW_PLANE_HULL means PBW_PLANE_EVEN_ODD.  Segment k starts at point k. */
PBWDEF pbw_status pbw_plane_rings(const double *points, const size_t *first, size_t ring_count,
                                  const pbw_plane_options *options, pbw_plane *plane);
/* Frees what a plane holds and zeroes it; fine on {0}, fine twice. */
PBWDEF void pbw_plane_free(pbw_plane *plane);

#ifdef __cplusplus
}
#endif
#endif /* PBW_MESH2_H */

#if defined(PBW_MESH2_IMPLEMENTATION) && !defined(PBWM2__IMPLEMENTED)
#define PBWM2__IMPLEMENTED

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
/* No contraction: fused operations would give other coordinates. */
PBW_CONTRACTION_OFF

/* ------------------------------------------------------------------------------------------------------
   >>memory       Memory: growing arrays through options.resize.
   Holds: fault of a job is PBW_OK until an array could not grow or progress cancelled, and then stays what
   pbwm2__hand_over returns: no result is made of arrays that lack items.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwm2__job pbwm2__job;
typedef double pbwm2__vector[2];
typedef PBW_ARRAY(double) pbwm2__doubles;
typedef PBW_ARRAY(pbw_index) pbwm2__indices;

static int pbwm2__out_of_memory(pbwm2__job *job);                    /* sets the fault.  Returns 0 */

#define PBWM2__FIT(job, array, wanted) (PBW_FIT(&(job)->memory, array, wanted) || pbwm2__out_of_memory(job))
#define PBWM2__RESERVE(job, array, more) (PBW_RESERVE(&(job)->memory, array, more) || pbwm2__out_of_memory(job))
#define PBWM2__PUSH(job, array, item) (PBW_PUSH(&(job)->memory, array, item) || pbwm2__out_of_memory(job))

/* ------------------------------------------------------------------------------------------------------
   >>job          A call, and its triangles.
   Holds: links of neighbours name each other; slots that are free are a list; arrays grow before they are written.
   Triangle t has corners v, counter-clockwise.  Edge i is opposite to corner i; link[i] is the code 4 t' + i' of that
   edge in the triangle beyond, or PBW_NONE.  edge[i] is its constraint: PBW_NONE, a piece, or a group of pieces.
   A free slot has v[0] = PBW_NONE, and link[0] leads to the next free one.
   Vertices are numbered along the curve of pbw_order; later points follow.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwm2__triangle {
    pbw_index v[3], link[3], edge[3];
    pbw_index region;                      /* component of the plane less the segments; top bit: in a cavity */
} pbwm2__triangle;

typedef struct pbwm2__piece { pbw_index a, b, segment; } pbwm2__piece; /* of that segment of the caller, a to b */
typedef PBW_ARRAY(pbwm2__piece) pbwm2__pieces;
/* A vertex of a chain.  slot: for the triangle with this apex, PBW_NONE: any free one.  link, edge: of the edge to
   the next vertex; link 4 i + 3: that edge is also the one from vertex i. */
typedef struct pbwm2__joint { pbw_index v, slot, link, edge; } pbwm2__joint;
typedef struct pbwm2__group { pbw_index piece, rest; } pbwm2__group; /* rest: a piece, or a further group */

typedef struct pbwm2__component {
    size_t first, count;                   /* codes of the edges of segments round it, in item_of */
    pbw_index seed;
    int winding, known, dead;
} pbwm2__component;

typedef struct pbwm2__host {               /* an edge of the constrained triangulation */
    pbw_index a, b, edge;
    int stuck;                             /* 1: a part of it could not be split, for want of digits */
    int acute;                             /* 1: it meets another one at less than 60 degrees */
} pbwm2__host;

#define PBWM2__CAVITY 0x80000000u
#define PBWM2__SLOT(code) ((code) >> 2)
#define PBWM2__SIDE(code) ((code) & 3u)
#define PBWM2__TRIANGLES_MOST 0x3fffffffu

static const unsigned char pbwm2__next[3] = { 1, 2, 0 }, pbwm2__last[3] = { 2, 0, 1 };

struct pbwm2__job {
    pbw_memory memory;
    pbw_status fault;
    const pbw_plane_input *input;
    const pbw_plane_options *options;
    const pbw_options *build;
    pbw_plane *plane;
    pbwm2__triangle *t;                    /* = triangles.at */
    double *p;                             /* = points.at */
    pbw_index *incident;                   /* = incidents.at: per vertex a triangle */
    size_t piece_count;
    pbw_index free_slot;
    double floor;                          /* see signs */
    pbw_stage stage;                       /* that progress is of */
    size_t steps;                          /* since progress was reported */
    PBW_ARRAY(pbwm2__triangle) triangles;
    PBW_ARRAY(pbwm2__vector) points;
    pbwm2__indices incidents;
    PBW_ARRAY(pbwm2__vector) given;        /* the caller's points; crossings are added */
    pbwm2__pieces segments;                /* pieces in their numbers; parts are added */
    pbwm2__indices original;               /* per vertex: its number in given */
    pbwm2__indices vertex;                 /* and back; a duplicate has the vertex at its coordinates */
    pbwm2__pieces pieces;
    PBW_ARRAY(pbwm2__group) groups;
    PBW_ARRAY(pbwm2__joint) chain[2];      /* left and right of a segment */
    pbwm2__indices stack, old, fresh;      /* fresh: slots that were filled last */
    pbwm2__indices crossings;
    size_t side_count;                     /* sides of triangles with an edge, those of the border twice */
    PBW_ARRAY(pbwm2__host) hosts;          /* these three: see refinement */
    pbwm2__indices vertex_host;
    pbwm2__doubles sizes;
    pbwm2__indices first_of, item_of;      /* lists of various uses */
    PBW_ARRAY(pbwm2__component) components;
};

static int pbwm2__out_of_memory(pbwm2__job *job)
{
    job->fault = PBW_ERROR_MEMORY;
    return 0;
}

/* The caller's number of the segment that a piece is of. */
static pbw_index pbwm2__id_of(const pbwm2__job *job, pbwm2__piece piece)
{
    return job->input->segment_ids != NULL ? job->input->segment_ids[piece.segment] : piece.segment;
}

/* Takes the first piece off what an edge has: edge becomes the rest, PBW_NONE after the last. */
static pbwm2__piece pbwm2__take_piece(const pbwm2__job *job, pbw_index *edge)
{
    pbw_index number = *edge;
    *edge = PBW_NONE;
    if (number >= job->piece_count) {
        const pbwm2__group group = job->groups.at[number - job->piece_count];
        number = group.piece;
        *edge = group.rest;
    }
    return job->pieces.at[number];
}

static pbw_status pbwm2__say(pbwm2__job *job, pbw_status status, const char *text)
{
    snprintf(job->plane->what, sizeof job->plane->what, "%s", text != NULL ? text : pbw_status_string(status));
    return status;
}

/* Every loop that may be long calls it.  Returns nonzero if the call is cancelled. */
static int pbwm2__step(pbwm2__job *job, double done)
{
    if ((++job->steps & 1023) == 0 && job->build->progress != NULL && job->fault == PBW_OK
        && job->build->progress(job->build->progress_user, job->stage, done) != 0) {
        job->fault = PBW_CANCELLED;
    }
    return job->fault == PBW_CANCELLED;
}

/* The fraction of items that a loop has done. */
static double pbwm2__fraction(size_t i, size_t count)
{
    return (double)i / (double)count;
}

/* Takes a free slot, which the caller has reserved.  Invalidates no pointer. */
static pbw_index pbwm2__take_slot(pbwm2__job *job)
{
    pbw_index slot = job->free_slot;
    if (slot == PBW_NONE) {
        return (pbw_index)job->triangles.count++;
    }
    job->free_slot = job->t[slot].link[0];
    return slot;
}

static void pbwm2__free_slot(pbwm2__job *job, pbw_index slot)
{
    job->t[slot].v[0] = PBW_NONE;
    job->t[slot].link[0] = job->free_slot;
    job->free_slot = slot;
}

/* Makes sure that `count` slots can be taken. */
static int pbwm2__reserve_slots(pbwm2__job *job, size_t count)
{
    if (job->triangles.count + count > PBWM2__TRIANGLES_MOST) {
        job->fault = PBW_ERROR_TOO_LARGE;
        return 0;
    }
    if (!PBWM2__RESERVE(job, job->triangles, count)) {
        return 0;
    }
    job->t = job->triangles.at;
    return 1;
}

/* Joins two edges, either of which may be PBW_NONE. */
static void pbwm2__join(pbwm2__job *job, pbw_index one, pbw_index other)
{
    if (one != PBW_NONE) {
        job->t[PBWM2__SLOT(one)].link[PBWM2__SIDE(one)] = other;
    }
    if (other != PBW_NONE) {
        job->t[PBWM2__SLOT(other)].link[PBWM2__SIDE(other)] = one;
    }
}

static void pbwm2__mark_edge(pbwm2__job *job, pbw_index code, pbw_index edge)
{
    const pbw_index other = job->t[PBWM2__SLOT(code)].link[PBWM2__SIDE(code)];
    job->t[PBWM2__SLOT(code)].edge[PBWM2__SIDE(code)] = edge;
    if (other != PBW_NONE) {
        job->t[PBWM2__SLOT(other)].edge[PBWM2__SIDE(other)] = edge;
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>signs        Signs: filters here, the exact predicates of pbw.h behind them.
   In: points.  Out: exact signs.
   The bounds are those of Shewchuk 1997 ("Adaptive precision floating-point arithmetic and fast robust geometric
   predicates", A-stage): (3 + 16 e) e for orientations, (10 + 96 e) e for circles, e = 2^-53, times the sum of
   magnitudes.  They hold without underflow.  Where no coordinate is above 1e70, a product that underflows is off by
   2^-1075, and is multiplied by at most (2e70)^2 * 2 further on: below 1e-180 in all, which `floor` = 1e-170 covers.
   With larger coordinates floor is infinite, and every sign comes from pbw.h.
   ------------------------------------------------------------------------------------------------------ */
static void pbwm2__set_floor(pbwm2__job *job, size_t from)
{
    size_t i;
    job->floor = from == 0 ? 1e-170 : job->floor;
    for (i = 2 * from; i < 2 * job->points.count; i++) {
        job->floor = fabs(job->p[i]) > 1e70 ? HUGE_VAL : job->floor;
    }
}

static int pbwm2__orient_at(const pbwm2__job *job, const double *a, const double *b, const double *c)
{
    const double left = (a[0] - c[0]) * (b[1] - c[1]), right = (a[1] - c[1]) * (b[0] - c[0]), det = left - right;
    const double bound = 3.3306690738754716e-16 * (fabs(left) + fabs(right)) + job->floor;
    return det > bound ? 1 : det < -bound ? -1 : pbw_orient2(a, b, c);
}

static int pbwm2__orient(const pbwm2__job *job, pbw_index a, pbw_index b, pbw_index c)
{
    const double *p = job->p;
    return pbwm2__orient_at(job, p + 2 * (size_t)a, p + 2 * (size_t)b, p + 2 * (size_t)c);
}

static int pbwm2__conflict_at(const pbwm2__job *job, const double *a, const double *b, const double *c,
                              const double *d)
{
    const double ax = a[0] - d[0], ay = a[1] - d[1], bx = b[0] - d[0], by = b[1] - d[1];
    const double cx = c[0] - d[0], cy = c[1] - d[1];
    const double bc = bx * cy, cb = cx * by, ca = cx * ay, ac = ax * cy, ab = ax * by, ba = bx * ay;
    const double a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    const double det = a2 * (bc - cb) + b2 * (ca - ac) + c2 * (ab - ba);
    const double sum = a2 * (fabs(bc) + fabs(cb)) + b2 * (fabs(ca) + fabs(ac)) + c2 * (fabs(ab) + fabs(ba));
    const double bound = 1.1102230246251577e-15 * sum + job->floor;
    return det > bound ? 1 : det < -bound ? 0 : pbw_conflict2(a, b, c, d, NULL);
}

/* Returns whether d is in conflict with the triangle a b c: in its circle, ties by the rule of pbw.h. */
static int pbwm2__conflict(const pbwm2__job *job, pbw_index a, pbw_index b, pbw_index c, pbw_index d)
{
    const double *p = job->p;
    return pbwm2__conflict_at(job, p + 2 * (size_t)a, p + 2 * (size_t)b, p + 2 * (size_t)c, p + 2 * (size_t)d);
}

/* Returns whether a comes before b in an order that is monotonic along every line. */
static int pbwm2__before(const pbwm2__job *job, pbw_index a, pbw_index b)
{
    const double *p = job->p + 2 * (size_t)a, *q = job->p + 2 * (size_t)b;
    return p[0] < q[0] || (p[0] <= q[0] && p[1] < q[1]);
}

/* ------------------------------------------------------------------------------------------------------
   >>segments     Segments.
   In: a constrained triangulation, a segment.  Out: the triangulation with the segment, or that it crosses another.
   Holds: every free edge is locally regular, before and after.

   The triangles that a segment crosses leave a cavity, a polygon on each side of it, whose border is a chain of
   edges.  A polygon is refilled from its base: the apex of the triangle there is the vertex of the chain in whose
   circle no other lies, and both sides of the triangle are bases of smaller polygons (Anglada 1997).  A chain passes
   an edge that sticks out into the cavity twice; then the corner with the triangle in it counts, and the side of the
   edge that is filled first leaves its code to the other side.  New triangles take the slots of the old ones, so that
   neighbours stay close in memory.
   ------------------------------------------------------------------------------------------------------ */

/* Returns whether the direction u-x is in the counter-clockwise turn from u-from to u-to, ends included. */
static int pbwm2__in_turn(const pbwm2__job *job, pbw_index u, pbw_index from, pbw_index to, pbw_index x)
{
    const int turn = from == to ? -1 : pbwm2__orient(job, u, from, to);
    if (from == to) {
        return 1;
    }
    if (turn >= 0) {
        return pbwm2__orient(job, u, from, x) >= 0 && pbwm2__orient(job, u, x, to) >= 0;
    }
    return !(pbwm2__orient(job, u, to, x) > 0 && pbwm2__orient(job, u, x, from) > 0);
}

/* Returns the index of the apex for the base between vertices low and high of the chain; 0 if no vertex between them
   is on the inner side, which cannot happen in the cavity of a segment. */
static size_t pbwm2__apex(const pbwm2__job *job, const pbwm2__joint *chain, size_t low, size_t high)
{
    const pbw_index a = chain[low].v, b = chain[high].v;
    size_t best = 0, i;
    int repeats = 0;
    if (high - low == 2) {
        return low + 1;
    }
    for (i = low + 1; i < high; i++) {
        const pbw_index c = chain[i].v;
        repeats |= chain[i - 1].v == chain[i + 1].v;
        if (c == a || c == b || (best != 0 && c == chain[best].v)) {
            continue;
        }
        if ((best == 0 || pbwm2__conflict(job, a, b, chain[best].v, c)) && pbwm2__orient(job, a, b, c) > 0) {
            best = i;
        }
    }
    for (i = low + 1; repeats && best != 0 && i < high; i++) {
        const pbw_index c = chain[i].v;
        if (c == chain[best].v && pbwm2__in_turn(job, c, chain[i - 1].v, chain[i + 1].v, a)
            && pbwm2__in_turn(job, c, chain[i - 1].v, chain[i + 1].v, b)) {
            return i;
        }
    }
    return best;
}

/* The triangle on a base of the chain, with its apex.  Returns its slot. */
static pbw_index pbwm2__put(pbwm2__job *job, const pbwm2__joint *low, const pbwm2__joint *high,
                            const pbwm2__joint *apex, pbw_index region)
{
    const pbw_index slot = apex->slot != PBW_NONE ? apex->slot : pbwm2__take_slot(job);
    pbwm2__triangle *t = job->t + slot;
    t->v[0] = low->v;
    t->v[1] = high->v;
    t->v[2] = apex->v;
    t->edge[0] = t->edge[1] = t->edge[2] = PBW_NONE;
    t->region = region;
    job->incident[low->v] = job->incident[high->v] = job->incident[apex->v] = slot;
    return slot;
}

/* Fills the polygon between a chain of `count` vertices, counter-clockwise from its last to its first, and the base.
   Free slots are reserved.  Returns the code of the base in its triangle, PBW_NONE without memory or if there is no
   apex. */
static pbw_index pbwm2__fill(pbwm2__job *job, pbwm2__joint *chain, size_t count, pbw_index region)
{
    pbw_index base = PBW_NONE, *stack;
    size_t top = 3;
    job->stack.count = job->fresh.count = 0;
    if (!PBWM2__RESERVE(job, job->stack, 3 * (count + 2)) || !PBWM2__RESERVE(job, job->fresh, count)) {
        return PBW_NONE;
    }
    stack = job->stack.at;
    stack[0] = 0;
    stack[1] = (pbw_index)(count - 1);
    stack[2] = PBW_NONE;
    while (top > 0) {
        const pbw_index low = stack[top - 3], high = stack[top - 2], parent = stack[top - 1];
        const pbw_index link = chain[low].link;
        pbw_index slot;
        size_t apex;
        top -= 3;
        if (high - low == 1) {                       /* an edge of the chain */
            job->t[PBWM2__SLOT(parent)].edge[PBWM2__SIDE(parent)] = chain[low].edge;
            if (PBWM2__SIDE(link) == 3 && link != PBW_NONE) {
                chain[PBWM2__SLOT(link)].link = parent;
            } else {
                pbwm2__join(job, parent, link);
            }
            continue;
        }
        apex = pbwm2__apex(job, chain, low, high);
        if (apex == 0) {
            return PBW_NONE;
        }
        slot = pbwm2__put(job, chain + low, chain + high, chain + apex, region);
        pbwm2__join(job, 4 * slot + 2, parent);
        base = base == PBW_NONE ? 4 * slot + 2 : base;
        job->fresh.at[job->fresh.count++] = slot;
        stack[top] = low;
        stack[top + 1] = (pbw_index)apex;
        stack[top + 2] = 4 * slot + 1;
        stack[top + 3] = (pbw_index)apex;
        stack[top + 4] = high;
        stack[top + 5] = 4 * slot;
        top += 6;
    }
    return base;
}

/* Steps round corner `corner` (code 4 t + i of a corner): to the next triangle counter-clockwise, or the other way.
   */
static pbw_index pbwm2__round(const pbwm2__job *job, pbw_index corner, int clockwise)
{
    const unsigned i = PBWM2__SIDE(corner);
    const pbw_index link = job->t[PBWM2__SLOT(corner)].link[clockwise ? pbwm2__last[i] : pbwm2__next[i]];
    if (link == PBW_NONE) {
        return PBW_NONE;
    }
    return 4 * PBWM2__SLOT(link) + (clockwise ? pbwm2__last[PBWM2__SIDE(link)] : pbwm2__next[PBWM2__SIDE(link)]);
}

static pbw_index pbwm2__corner_of(const pbwm2__job *job, pbw_index vertex)
{
    const pbw_index slot = job->incident[vertex];
    const pbwm2__triangle *t = job->t + slot;
    return 4 * slot + (t->v[0] == vertex ? 0u : t->v[1] == vertex ? 1u : 2u);
}

typedef struct pbwm2__spin { pbw_index start, corner; int clockwise; } pbwm2__spin;     /* round a vertex */

/* The next triangle: counter-clockwise, then from the border the other way from the start.  Returns 0 at the end. */
static int pbwm2__spin_on(const pbwm2__job *job, pbwm2__spin *spin)
{
    spin->corner = pbwm2__round(job, spin->corner, spin->clockwise);
    if (spin->corner == PBW_NONE && !spin->clockwise) {
        spin->clockwise = 1;
        spin->corner = pbwm2__round(job, spin->start, 1);
    }
    return spin->corner != PBW_NONE && spin->corner != spin->start;
}

/* Returns the code of the edge between two vertices, in one of its triangles; PBW_NONE if there is none, and *fewer
   is then 1 if b has fewer triangles than a.  Searches round both alternately, as one may be a hub. */
static pbw_index pbwm2__look(const pbwm2__job *job, pbw_index a, pbw_index b, int *fewer)
{
    pbwm2__spin spin[2];
    int s;
    memset(spin, 0, sizeof spin);
    spin[0].start = spin[0].corner = pbwm2__corner_of(job, a);
    spin[1].start = spin[1].corner = pbwm2__corner_of(job, b);
    for (s = 0; ; s = 1 - s) {
        const unsigned i = PBWM2__SIDE(spin[s].corner);
        const pbw_index slot = PBWM2__SLOT(spin[s].corner), other = s == 0 ? b : a;
        if (job->t[slot].v[pbwm2__next[i]] == other) {
            return 4 * slot + pbwm2__last[i];
        }
        if (job->t[slot].v[pbwm2__last[i]] == other) {
            return 4 * slot + pbwm2__next[i];
        }
        if (!pbwm2__spin_on(job, spin + s)) {
            *fewer = s;
            return PBW_NONE;
        }
    }
}

static pbw_index pbwm2__find_edge(const pbwm2__job *job, pbw_index a, pbw_index b)
{
    int unused;
    return pbwm2__look(job, a, b, &unused);
}

/* For a segment from a to b that is no edge: returns the corner at a of the triangle by which it leaves the star of
   a, across the opposite edge; or sets *through to the neighbour of a that it passes through. */
static pbw_index pbwm2__find_exit(const pbwm2__job *job, pbw_index a, pbw_index b, pbw_index *through)
{
    const pbw_index start = pbwm2__corner_of(job, a);
    const int forwards = pbwm2__before(job, a, b);
    pbw_index corner;
    int clockwise, k;
    *through = PBW_NONE;
    for (clockwise = 0; clockwise < 2; clockwise++) {
        for (corner = start; corner != PBW_NONE; ) {
            const unsigned i = PBWM2__SIDE(corner);
            const pbwm2__triangle *t = job->t + PBWM2__SLOT(corner);
            const pbw_index ends[2] = { t->v[pbwm2__next[i]], t->v[pbwm2__last[i]] };
            int sign[2];
            for (k = 0; k < 2; k++) {
                sign[k] = pbwm2__orient(job, a, b, ends[k]);
                if (sign[k] == 0 && pbwm2__before(job, a, ends[k]) == forwards) {
                    *through = ends[k];
                    return corner;
                }
            }
            if (sign[0] < 0 && sign[1] > 0) {
                return corner;
            }
            corner = pbwm2__round(job, corner, clockwise);
            if (corner == start) {
                return PBW_NONE;
            }
        }
    }
    return PBW_NONE;
}

/* Adds a vertex, and the edge from there, by its code in an old triangle, to a chain. */
static int pbwm2__chain_push(pbwm2__job *job, int side, pbw_index vertex, pbw_index inner)
{
    pbwm2__joint joint;
    joint.v = vertex;
    joint.slot = PBWM2__SLOT(inner);
    joint.link = inner;
    joint.edge = PBW_NONE;
    return PBWM2__PUSH(job, job->chain[side], joint);
}

static int pbwm2__dig_old(pbwm2__job *job, pbw_index slot)
{
    job->t[slot].region |= PBWM2__CAVITY;
    return PBWM2__PUSH(job, job->old, slot);
}

/* Collects the cavity of a segment from a towards b: both chains, and the old triangles.  Returns the vertex at its
   end: b, or another one on the segment; PBW_NONE without memory, or if it crosses a segment (then *crossed is that
   edge). */
static pbw_index pbwm2__cavity(pbwm2__job *job, pbw_index corner, pbw_index b, pbw_index *crossed)
{
    const unsigned i = PBWM2__SIDE(corner);
    pbw_index slot = PBWM2__SLOT(corner), a = job->t[slot].v[i];
    pbw_index right = job->t[slot].v[pbwm2__next[i]], left = job->t[slot].v[pbwm2__last[i]], edge = corner;
    int ok = 1;
    job->chain[0].count = job->chain[1].count = job->old.count = 0;
    ok = pbwm2__chain_push(job, 0, a, 4 * slot + pbwm2__next[i])
      && pbwm2__chain_push(job, 1, a, 4 * slot + pbwm2__last[i]) && pbwm2__dig_old(job, slot);
    while (ok) {
        const pbw_index link = job->t[PBWM2__SLOT(edge)].link[PBWM2__SIDE(edge)];
        const unsigned e = PBWM2__SIDE(link);
        pbw_index x, to_left, to_right;
        int sign;
        *crossed = job->t[PBWM2__SLOT(edge)].edge[PBWM2__SIDE(edge)];
        if (*crossed != PBW_NONE) {
            return PBW_NONE;
        }
        slot = PBWM2__SLOT(link);
        x = job->t[slot].v[e];
        to_left = 4 * slot + pbwm2__last[e];         /* the edges from x to left and to right */
        to_right = 4 * slot + pbwm2__next[e];
        sign = x == b ? 0 : pbwm2__orient(job, a, b, x);
        ok = pbwm2__dig_old(job, slot)
          && (sign < 0 || pbwm2__chain_push(job, 0, left, to_left))
          && (sign > 0 || pbwm2__chain_push(job, 1, right, to_right));
        if (sign == 0) {
            pbwm2__joint *right_last = job->chain[1].at + job->chain[1].count - 1;
            right_last->slot = ok ? job->old.at[0] : PBW_NONE;       /* the one left over */
            ok = ok && pbwm2__chain_push(job, 0, x, PBW_NONE) && pbwm2__chain_push(job, 1, x, PBW_NONE);
            return ok ? x : PBW_NONE;
        }
        left = sign > 0 ? x : left;
        right = sign < 0 ? x : right;
        edge = sign > 0 ? to_right : to_left;
    }
    return PBW_NONE;
}

/* Turns a chain round: it begins with its last vertex, edges stay between their vertices. */
static void pbwm2__reverse(pbwm2__joint *chain, size_t count)
{
    size_t i;
    for (i = 0; i < count / 2; i++) {
        pbwm2__joint *one = chain + i, *other = chain + count - 1 - i;
        const pbwm2__joint swap = *one;
        one->v = other->v;
        one->slot = other->slot;
        other->v = swap.v;
        other->slot = swap.slot;
    }
    for (i = 0; i < (count - 1) / 2; i++) {
        pbwm2__joint *one = chain + i, *other = chain + count - 2 - i;
        const pbwm2__joint swap = *one;
        one->link = other->link;
        one->edge = other->edge;
        other->link = swap.link;
        other->edge = swap.edge;
    }
}

/* Replaces codes in old triangles by what is beyond, as these triangles go. */
static void pbwm2__look_beyond(pbwm2__job *job, pbwm2__joint *chain, size_t count)
{
    size_t i;
    for (i = 0; i + 1 < count; i++) {
        const pbwm2__triangle *t = job->t + PBWM2__SLOT(chain[i].link);
        const unsigned side = PBWM2__SIDE(chain[i].link);
        const pbw_index link = t->link[side];
        chain[i].edge = t->edge[side];
        chain[i].link = link;
        if (link != PBW_NONE && PBWM2__SIDE(link) == 3) {
            chain[PBWM2__SLOT(link)].link = (pbw_index)(4 * i + 3);
        } else if (link != PBW_NONE && (job->t[PBWM2__SLOT(link)].region & PBWM2__CAVITY) != 0) {
            job->t[PBWM2__SLOT(link)].link[PBWM2__SIDE(link)] = (pbw_index)(4 * i + 3);
        }
    }
}

/* Replaces the triangles of a cavity.  Returns the code of the segment's edge; PBW_NONE without memory. */
static pbw_index pbwm2__refill(pbwm2__job *job)
{
    pbwm2__joint *left = job->chain[0].at, *right = job->chain[1].at;
    pbw_index base[2];
    pbwm2__reverse(right, job->chain[1].count);
    pbwm2__look_beyond(job, left, job->chain[0].count);
    pbwm2__look_beyond(job, right, job->chain[1].count);
    base[0] = pbwm2__fill(job, left, job->chain[0].count, 0);
    base[1] = base[0] == PBW_NONE ? PBW_NONE : pbwm2__fill(job, right, job->chain[1].count, 0);
    if (base[1] == PBW_NONE) {
        return PBW_NONE;
    }
    pbwm2__join(job, base[0], base[1]);
    return base[0];
}

/* Adds a piece to an edge, which may have others.  Returns 0 without memory. */
static int pbwm2__add_piece(pbwm2__job *job, pbw_index code, pbw_index piece)
{
    const pbw_index rest = job->t[PBWM2__SLOT(code)].edge[PBWM2__SIDE(code)];
    pbwm2__group *groups;
    if (rest == PBW_NONE) {
        pbwm2__mark_edge(job, code, piece);
        return 1;
    }
    if (!PBWM2__RESERVE(job, job->groups, 1)) {
        return 0;
    }
    groups = job->groups.at;
    if (job->groups.count == 0 || groups[job->groups.count - 1].piece != piece
        || groups[job->groups.count - 1].rest != rest) {
        groups[job->groups.count].piece = piece;
        groups[job->groups.count++].rest = rest;
    }
    pbwm2__mark_edge(job, code, (pbw_index)(job->piece_count + job->groups.count - 1));
    return 1;
}

enum { PBWM2__DONE, PBWM2__CROSSES, PBWM2__NO_MEMORY };

static int pbwm2__insert_piece(pbwm2__job *job, pbw_index number)
{
    const pbwm2__piece piece = job->pieces.at[number];
    pbw_index a = piece.a, b = piece.b, end, crossed = PBW_NONE;
    while (a != b) {
        int fewer = 0;
        pbw_index code = pbwm2__look(job, a, b, &fewer), corner;
        if (fewer) {
            end = a;
            a = b;
            b = end;
        }
        end = b;
        if (code == PBW_NONE) {
            corner = pbwm2__find_exit(job, a, b, &end);
            if (end != PBW_NONE) {
                code = pbwm2__find_edge(job, a, end);
            } else {
                end = pbwm2__cavity(job, corner, b, &crossed);
                if (end == PBW_NONE) {
                    return crossed != PBW_NONE ? PBWM2__CROSSES : PBWM2__NO_MEMORY;
                }
                code = pbwm2__refill(job);
                if (code == PBW_NONE) {
                    return PBWM2__NO_MEMORY;
                }
            }
        }
        if (!pbwm2__add_piece(job, code, number)) {
            return PBWM2__NO_MEMORY;
        }
        a = end;
    }
    return PBWM2__DONE;
}

/* ---- the triangulation of the points */

/* Takes over the arrays of a mesh: links with the number of the edge, instead of neighbours. */
static pbw_status pbwm2__take_mesh(pbwm2__job *job, const pbw_mesh *mesh)
{
    const pbw_index *neighbor = mesh->neighbors;
    const size_t n = mesh->point_count;
    size_t i, k;
    job->triangles.count = job->points.count = job->incidents.count = job->original.count = job->vertex.count = 0;
    if (mesh->simplex_count > PBWM2__TRIANGLES_MOST) {
        return PBW_ERROR_TOO_LARGE;
    }
    if (!pbwm2__reserve_slots(job, mesh->simplex_count)
        || !PBWM2__RESERVE(job, job->points, n) || !PBWM2__RESERVE(job, job->incidents, n)
        || !PBWM2__RESERVE(job, job->original, n) || !PBWM2__RESERVE(job, job->vertex, n)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < mesh->simplex_count; i++) {
        for (k = 0; k < 3; k++) {
            const pbw_index other = neighbor[3 * i + k];
            pbw_index side = 0;
            if (other != PBW_NONE) {
                const pbw_index *back = neighbor + 3 * (size_t)other;
                side = (pbw_index)(back[1] == i) + 2 * (pbw_index)(back[2] == i);
            }
            job->t[i].v[k] = mesh->simplices[3 * i + k];
            job->t[i].link[k] = other == PBW_NONE ? PBW_NONE : 4 * other + side;
            job->t[i].edge[k] = PBW_NONE;
        }
        job->t[i].region = 0;
    }
    job->triangles.count = mesh->simplex_count;
    job->points.count = job->incidents.count = job->original.count = job->vertex.count = n;
    job->p = job->points.at[0];
    job->incident = job->incidents.at;
    memcpy(job->p, mesh->points, n * 2 * sizeof(double));
    memcpy(job->incident, mesh->incident, n * sizeof(pbw_index));
    memcpy(job->original.at, mesh->original, n * sizeof(pbw_index));
    for (i = 0; i < n; i++) {
        job->vertex.at[mesh->original[i]] = mesh->canonical[i];
    }
    job->free_slot = PBW_NONE;
    pbwm2__set_floor(job, 0);
    return PBW_OK;
}

static pbw_status pbwm2__triangulate(pbwm2__job *job)
{
    pbw_options options = *job->build;
    pbw_mesh mesh;
    pbw_status status;
    memset(&mesh, 0, sizeof mesh);
    options.flags = (options.flags & PBW_BACKEND_OR_CPU) | PBW_CURVE_ORDER;
    options.stride = 0;
    options.trace = NULL;
    options.memory_limit = pbw_memory_left(&job->memory);
    status = pbw_triangulate(2, job->given.at[0], NULL, job->given.count, &options, &mesh);
    if (status == PBW_OK) {
        const size_t held = mesh.statistics.peak_bytes;          /* at most: the mesh has some of them */
        job->memory.used += held;
        status = pbwm2__take_mesh(job, &mesh);
        job->memory.used -= held;
    }
    pbw_free(&mesh);
    return status == PBW_OK ? status : pbwm2__say(job, status, NULL);
}

/* Fills pieces from the segments: ends become vertices; in the order of the first of the two on the curve. */
static pbw_status pbwm2__order_pieces(pbwm2__job *job)
{
    const pbwm2__piece *segment = job->segments.at;
    const pbw_index *vertex = job->vertex.at;
    const size_t count = job->segments.count, n = job->points.count;
    pbw_index *first;
    size_t i, sum = 0;
    job->pieces.count = job->first_of.count = 0;
    job->groups.count = 0;
    if (!PBWM2__RESERVE(job, job->pieces, count) || !PBWM2__RESERVE(job, job->first_of, n + 1)) {
        return pbwm2__say(job, PBW_ERROR_MEMORY, NULL);
    }
    first = job->first_of.at;
    memset(first, 0, (n + 1) * sizeof *first);
    for (i = 0; i < count; i++) {
        const pbw_index a = vertex[segment[i].a], b = vertex[segment[i].b];
        first[a < b ? a : b]++;
    }
    for (i = 0; i < n; i++) {
        const pbw_index here = first[i];
        first[i] = (pbw_index)sum;
        sum += here;
    }
    for (i = 0; i < count; i++) {
        const pbw_index a = vertex[segment[i].a], b = vertex[segment[i].b];
        pbwm2__piece *piece = job->pieces.at + first[a < b ? a : b]++;
        piece->a = a;
        piece->b = b;
        piece->segment = segment[i].segment;
    }
    job->pieces.count = job->piece_count = count;
    return PBW_OK;
}

/* Triangulates the points and inserts all pieces; *crosses is set if two of them cross. */
static pbw_status pbwm2__constrain(pbwm2__job *job, int *crosses)
{
    pbw_status status = pbwm2__triangulate(job);
    size_t i;
    *crosses = 0;
    if (status == PBW_OK) {
        status = pbwm2__order_pieces(job);
    }
    for (i = 0; status == PBW_OK && i < job->piece_count; i++) {
        const int result = pbwm2__insert_piece(job, (pbw_index)i);
        if (result == PBWM2__NO_MEMORY) {
            status = pbwm2__say(job, PBW_ERROR_MEMORY, NULL);
        } else if (result == PBWM2__CROSSES) {
            *crosses = 1;
            return PBW_OK;
        } else if (pbwm2__step(job, pbwm2__fraction(i, job->piece_count))) {
            status = pbwm2__say(job, PBW_CANCELLED, NULL);
        }
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>crossings    Pairs of segments with a point inside both, by a tree of boxes over the segments along the curve.
   In: segments.  Out: all such pairs, or segments cut there.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwm2__box { double low[2], high[2]; } pbwm2__box;
typedef struct pbwm2__cut { double at; pbw_index segment, other; } pbwm2__cut;   /* other: a segment, or a point */
typedef PBW_ARRAY(pbwm2__cut) pbwm2__cuts;
enum { PBWM2__LEVELS = 17, PBWM2__FAN = 4, PBWM2__ROUNDS = 16 };

typedef struct pbwm2__tree {
    pbwm2__indices order;
    PBW_ARRAY(pbwm2__box) boxes;
    size_t first[PBWM2__LEVELS + 1], count[PBWM2__LEVELS];           /* of the boxes of each level; 0: the segments */
    int levels;
} pbwm2__tree;

/* By segments, then along them. */
static int pbwm2__compare_cuts(const void *left, const void *right)
{
    const pbwm2__cut *a = (const pbwm2__cut *)left, *b = (const pbwm2__cut *)right;
    if (a->segment != b->segment) {
        return a->segment < b->segment ? -1 : 1;
    }
    return a->at < b->at ? -1 : a->at > b->at ? 1 : (a->other > b->other) - (a->other < b->other);
}

static void pbwm2__sort(pbwm2__cuts *cuts)
{
    if (cuts->count > 1) {
        qsort(cuts->at, cuts->count, sizeof *cuts->at, pbwm2__compare_cuts);
    }
}

static void pbwm2__widen(pbwm2__box *box, const double *low, const double *high)
{
    int k;
    for (k = 0; k < 2; k++) {
        box->low[k] = low[k] < box->low[k] ? low[k] : box->low[k];
        box->high[k] = high[k] > box->high[k] ? high[k] : box->high[k];
    }
}

static pbw_status pbwm2__build_tree(pbwm2__job *job, pbwm2__tree *tree)
{
    const pbwm2__piece *segment = job->segments.at;
    const double *p = job->given.at[0];
    const size_t m = job->segments.count;
    pbw_options options = *job->build;
    PBW_ARRAY(pbwm2__vector) middles;
    pbwm2__box *box;
    pbw_status status;
    size_t i, k, total = m, n = m;
    memset(&middles, 0, sizeof middles);
    for (tree->levels = 1, tree->count[0] = m; n > PBWM2__FAN; tree->levels++) {
        n = (n + PBWM2__FAN - 1) / PBWM2__FAN;
        tree->count[tree->levels] = n;
        total += n;
    }
    if (!PBWM2__RESERVE(job, middles, m) || !PBWM2__RESERVE(job, tree->order, m)
        || !PBWM2__RESERVE(job, tree->boxes, total)) {
        PBW_RELEASE(&job->memory, middles);
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < m; i++) {
        for (k = 0; k < 2; k++) {
            const double a = p[2 * (size_t)segment[i].a + k], b = p[2 * (size_t)segment[i].b + k];
            middles.at[i][k] = a / 2 + b / 2;
        }
    }
    options.stride = 0;
    options.memory_limit = pbw_memory_left(&job->memory);
    status = pbw_order(2, middles.at[0], m, &options, tree->order.at);
    PBW_RELEASE(&job->memory, middles);
    box = tree->boxes.at;
    for (i = 0; status == PBW_OK && i < m; i++) {
        const pbwm2__piece s = segment[tree->order.at[i]];
        memcpy(box[i].low, p + 2 * (size_t)s.a, sizeof box[i].low);
        memcpy(box[i].high, p + 2 * (size_t)s.a, sizeof box[i].high);
        pbwm2__widen(box + i, p + 2 * (size_t)s.b, p + 2 * (size_t)s.b);
    }
    tree->first[0] = 0;
    for (k = 1; status == PBW_OK && k < (size_t)tree->levels; k++) {
        const pbwm2__box *below = box + tree->first[k - 1];
        tree->first[k] = tree->first[k - 1] + tree->count[k - 1];
        for (i = 0; i < tree->count[k - 1]; i++) {
            pbwm2__box *above = box + tree->first[k] + i / PBWM2__FAN;
            if (i % PBWM2__FAN == 0) {
                *above = below[i];
            }
            pbwm2__widen(above, below[i].low, below[i].high);
        }
    }
    return status;
}

static int pbwm2__cross(const pbwm2__job *job, pbwm2__piece s, pbwm2__piece t)
{
    const double *a = job->given.at[s.a], *b = job->given.at[s.b];
    const double *c = job->given.at[t.a], *d = job->given.at[t.b];
    return pbwm2__orient_at(job, a, b, c) * pbwm2__orient_at(job, a, b, d) < 0
        && pbwm2__orient_at(job, c, d, a) * pbwm2__orient_at(job, c, d, b) < 0;
}

static int pbwm2__add_cut(pbwm2__job *job, pbwm2__cuts *cuts, pbw_index segment, pbw_index other, double at)
{
    pbwm2__cut cut;
    cut.segment = segment;
    cut.other = other;
    cut.at = at;
    return PBWM2__PUSH(job, *cuts, cut);
}

/* Adds the pairs of the segment of leaf i of the tree with those of later leaves. */
static int pbwm2__pairs_of(pbwm2__job *job, const pbwm2__tree *tree, size_t i, pbwm2__cuts *pairs)
{
    const pbwm2__piece *segment = job->segments.at;
    const pbw_index *order = tree->order.at;
    const pbwm2__box *box = tree->boxes.at, mine = box[i];
    size_t stack[PBWM2__LEVELS * PBWM2__FAN], top = 0, n = tree->count[tree->levels - 1], width = 1, k;
    int level[PBWM2__LEVELS * PBWM2__FAN];
    for (k = 0; k < n; k++) {
        stack[top] = k;
        level[top++] = tree->levels - 1;
    }
    while (top > 0) {
        const size_t node = stack[--top];
        const int l = level[top];
        const pbwm2__box *b = box + tree->first[l] + node;
        for (width = 1, k = 0; k < (size_t)l; k++) {
            width *= PBWM2__FAN;
        }
        if ((node + 1) * width <= i + 1 || b->low[0] > mine.high[0] || b->high[0] < mine.low[0]
            || b->low[1] > mine.high[1] || b->high[1] < mine.low[1]) {
            continue;
        }
        if (l == 0) {
            const pbw_index s = order[i], t = order[node];
            if (pbwm2__cross(job, segment[s], segment[t])
                && !pbwm2__add_cut(job, pairs, s < t ? s : t, s < t ? t : s, 0)) {
                return 0;
            }
            continue;
        }
        for (k = PBWM2__FAN * node; k < PBWM2__FAN * (node + 1) && k < tree->count[l - 1]; k++) {
            stack[top] = k;
            level[top++] = l - 1;
        }
    }
    return 1;
}

static pbw_status pbwm2__find_pairs(pbwm2__job *job, pbwm2__cuts *pairs)
{
    pbwm2__tree tree;
    pbw_status status;
    size_t i;
    memset(&tree, 0, sizeof tree);
    pairs->count = 0;
    status = pbwm2__build_tree(job, &tree);
    for (i = 0; status == PBW_OK && i < job->segments.count; i++) {
        status = !pbwm2__pairs_of(job, &tree, i, pairs) ? PBW_ERROR_MEMORY
               : pbwm2__step(job, pbwm2__fraction(i, job->segments.count)) ? PBW_CANCELLED : PBW_OK;
    }
    PBW_RELEASE(&job->memory, tree.order);
    PBW_RELEASE(&job->memory, tree.boxes);
    if (status == PBW_OK) {
        pbwm2__sort(pairs);
    }
    return status == PBW_OK ? status : pbwm2__say(job, status, NULL);
}

/* Cuts segments at the points on them, so that no point is where two parts cross.  Walks through the triangulation of
   the points, without constraints. */
static pbw_status pbwm2__cut_at_points(pbwm2__job *job)
{
    const pbw_index *vertex = job->vertex.at, *original = job->original.at;
    pbwm2__pieces parts;
    pbw_status status = pbwm2__triangulate(job);
    size_t i;
    memset(&parts, 0, sizeof parts);
    for (i = 0; status == PBW_OK && i < job->segments.count; i++) {
        pbwm2__piece s = job->segments.at[i];
        const pbw_index b = vertex[s.b];
        pbw_index a = vertex[s.a], crossed;
        while (status == PBW_OK && a != b) {
            pbw_index end = b, code = pbwm2__find_edge(job, a, b);
            if (code == PBW_NONE) {
                code = pbwm2__find_exit(job, a, b, &end);
                end = end != PBW_NONE ? end : pbwm2__cavity(job, code, b, &crossed);
            }
            if (end != PBW_NONE) {
                s.a = original[a];
                s.b = original[end];
                a = end;
            }
            if (end == PBW_NONE || !PBWM2__PUSH(job, parts, s)) {
                status = pbwm2__say(job, PBW_ERROR_MEMORY, NULL);
            }
        }
    }
    if (status == PBW_OK) {
        PBW_RELEASE(&job->memory, job->segments);
        job->segments = parts;
    } else {
        PBW_RELEASE(&job->memory, parts);
    }
    return status;
}

/* ---- the crossing of two segments, in pairs of doubles */

/* Computes the crossing of a-b with c-d, where corner is a, b, c, d.  It is rounded to the grid of the doubles just
   below 2^exponent, which no coordinate reaches: to the nearest point unless the segments are parallel to 14 digits,
   and never outside of the boxes of both.  On the finer grid near 0, rounded crossings would keep making new ones.
   Returns how far along a-b it is, 0 to 1. */
static double pbwm2__crossing(const double *const corner[4], int exponent, double out[2])
{
    double x[4][2], at;
    pbw_pair ab[2], cd[2], ac[2], up, down, q;
    int i, k;
    for (i = 0; i < 8; i++) {                        /* within -1/2 .. 1/2 */
        x[i / 2][i % 2] = ldexp(corner[i / 2][i % 2], -exponent - 1);
    }
    for (k = 0; k < 2; k++) {
        ab[k] = pbw_two_sum(x[1][k], -x[0][k]);
        cd[k] = pbw_two_sum(x[3][k], -x[2][k]);
        ac[k] = pbw_two_sum(x[2][k], -x[0][k]);
    }
    up = pbw_pair_minor(ac[0], ac[1], cd[0], cd[1]);
    down = pbw_pair_minor(ab[0], ab[1], cd[0], cd[1]);
    at = fabs(down.head) > 0 ? up.head / down.head : 0.5;
    at = at >= 0 && at <= 1 ? at : at < 0 ? 0 : 1;
    q.head = at;
    q.tail = 0;
    if (fabs(down.head) > 0) {                       /* the rest of the quotient, from the rest of the division */
        const pbw_pair back = pbw_pair_times(q, down), rest = pbw_two_sum(up.head, -back.head);
        q = pbw_two_sum(at, (rest.head + (rest.tail + (up.tail - back.tail))) / down.head);
    }
    for (k = 0; k < 2; k++) {
        const double a = corner[0][k], b = corner[1][k], c = corner[2][k], d = corner[3][k];
        const double low = fmax(fmin(a, b), fmin(c, d)), high = fmin(fmax(a, b), fmax(c, d));
        const pbw_pair step = pbw_pair_times(q, ab[k]), sum = pbw_two_sum(x[0][k], step.head);
        const double steps = ldexp(sum.head + (sum.tail + step.tail), 54);
        const double y = ldexp(floor(steps + 0.5), exponent - 53);
        out[k] = y < low ? low : y > high ? high : y;
    }
    return at;
}

static int pbwm2__place_before(const double *a, const double *b)
{
    return a[0] < b[0] || (a[0] <= b[0] && a[1] < b[1]);
}

/* Makes the cuts of two segments that cross, at a new point, or at an end that is not farther from it than `near`. */
static int pbwm2__cut_pair(pbwm2__job *job, pbwm2__cut pair, int exponent, double nearby, pbwm2__cuts *cuts)
{
    const pbwm2__piece *segment = job->segments.at;
    const double *corner[6];
    double *p = job->given.at[0], out[2], unused[2], at[2], best = nearby;
    pbw_index end[4], number[2], point = (pbw_index)job->given.count;
    int turned[2], i, k;
    number[0] = pair.segment;
    number[1] = pair.other;
    for (i = 0; i < 2; i++) {                        /* the same point for every order of segments and ends */
        const pbwm2__piece s = segment[number[i]];
        turned[i] = pbwm2__place_before(p + 2 * (size_t)s.b, p + 2 * (size_t)s.a);
        end[2 * i] = turned[i] ? s.b : s.a;
        end[2 * i + 1] = turned[i] ? s.a : s.b;
    }
    k = pbwm2__place_before(p + 2 * (size_t)end[2], p + 2 * (size_t)end[0])
     || (!pbwm2__place_before(p + 2 * (size_t)end[0], p + 2 * (size_t)end[2])
         && pbwm2__place_before(p + 2 * (size_t)end[3], p + 2 * (size_t)end[1]));
    for (i = 0; i < 6; i++) {
        corner[i] = p + 2 * (size_t)end[(i + 2 * k) % 4];
    }
    at[k] = pbwm2__crossing(corner, exponent, out);
    at[1 - k] = pbwm2__crossing(corner + 2, exponent, unused);
    for (i = 0; i < 4; i++) {
        const double apart = fmax(fabs(corner[i][0] - out[0]), fabs(corner[i][1] - out[1]));
        if (apart < best) {
            best = apart;
            point = end[(i + 2 * k) % 4];
        }
    }
    if (point == job->given.count) {
        memcpy(job->given.at[job->given.count++], out, sizeof out);
    }
    return pbwm2__add_cut(job, cuts, number[0], point, turned[0] ? 1 - at[0] : at[0])
        && pbwm2__add_cut(job, cuts, number[1], point, turned[1] ? 1 - at[1] : at[1]);
}

/* Replaces the segments by their parts between cuts, which are sorted. */
static int pbwm2__cut_segments(pbwm2__job *job, const pbwm2__cuts *cuts)
{
    const pbwm2__cut *cut = cuts->at;
    pbwm2__pieces parts;
    size_t i, k = 0;
    memset(&parts, 0, sizeof parts);
    if (!PBWM2__RESERVE(job, parts, job->segments.count + cuts->count)) {
        return 0;
    }
    for (i = 0; i < job->segments.count; i++) {
        pbwm2__piece s = job->segments.at[i], part = s;
        for (; k < cuts->count && cut[k].segment == i; k++) {
            part.b = cut[k].other;
            parts.at[parts.count++] = part;
            part.a = part.b;
        }
        part.b = s.b;
        parts.at[parts.count++] = part;
    }
    PBW_RELEASE(&job->memory, job->segments);
    job->segments = parts;
    return 1;
}

/* Cuts segments at their crossings: adds points to given, and replaces segments by their parts.  A part that passes
   an ulp beside a point could have new crossings in every round, so from the second round on a crossing near an end
   is moved there, and the distance that counts as near doubles from round to round. */
static pbw_status pbwm2__split(pbwm2__job *job, const pbwm2__cuts *pairs)
{
    pbwm2__cuts cuts;
    double most = 0;
    size_t i;
    int ok, exponent;
    memset(&cuts, 0, sizeof cuts);
    for (i = 0; i < 2 * job->given.count; i++) {
        most = fmax(most, fabs(job->given.at[i / 2][i % 2]));
    }
    (void)frexp(most, &exponent);
    ok = PBWM2__RESERVE(job, job->given, pairs->count);
    for (i = 0; ok && i < pairs->count; i++) {
        const int round = job->plane->report.rounds;
        ok = pbwm2__cut_pair(job, pairs->at[i], exponent,
                             round > 1 ? ldexp(1.5, exponent - 53 + round - 2) : 0, &cuts);
    }
    if (ok) {
        pbwm2__sort(&cuts);
        ok = pbwm2__cut_segments(job, &cuts);
    }
    PBW_RELEASE(&job->memory, cuts);
    return ok ? PBW_OK : pbwm2__say(job, PBW_ERROR_MEMORY, NULL);
}

/* Reports all crossings: the error of an input that has some. */
static pbw_status pbwm2__refuse(pbwm2__job *job, pbwm2__cuts *pairs)
{
    pbwm2__cut *pair = pairs->at;
    size_t i;
    for (i = 0; i < pairs->count; i++) {
        const pbw_index s = pbwm2__id_of(job, job->segments.at[pair[i].segment]);
        const pbw_index t = pbwm2__id_of(job, job->segments.at[pair[i].other]);
        pair[i].segment = s < t ? s : t;
        pair[i].other = s < t ? t : s;
    }
    pbwm2__sort(pairs);
    if (!PBWM2__RESERVE(job, job->crossings, 2 * pairs->count)) {
        return pbwm2__say(job, PBW_ERROR_MEMORY, NULL);
    }
    for (i = 0; i < pairs->count; i++) {
        job->crossings.at[2 * i] = pair[i].segment;
        job->crossings.at[2 * i + 1] = pair[i].other;
    }
    job->crossings.count = 2 * pairs->count;
    snprintf(job->plane->what, sizeof job->plane->what, "segments %u and %u cross; crossings in all: %lu",
             (unsigned)pair[0].segment, (unsigned)pair[0].other, (unsigned long)pairs->count);
    return PBW_ERROR_ARGUMENT;
}

/* Makes the constrained triangulation.  Each round splits segments that cross; one or two rounds are usual.  If
   coordinates have very different exponents, parts bent by rounding can keep crossing: then it gives up. */
static pbw_status pbwm2__constrain_all(pbwm2__job *job)
{
    pbwm2__cuts pairs;
    pbw_status status;
    size_t most = 0;
    int crosses = 0;
    memset(&pairs, 0, sizeof pairs);
    status = pbwm2__constrain(job, &crosses);
    while (status == PBW_OK && crosses) {
        status = pbwm2__cut_at_points(job);
        if (status == PBW_OK) {
            status = pbwm2__find_pairs(job, &pairs);
        }
        if (status == PBW_OK && (job->options->flags & PBW_PLANE_SPLIT_CROSSINGS) == 0) {
            status = pbwm2__refuse(job, &pairs);
        } else if (status == PBW_OK && (job->plane->report.rounds == PBWM2__ROUNDS
                                        || (most != 0 && job->segments.count > most))) {
            status = pbwm2__say(job, PBW_ERROR_ARGUMENT, "rounded crossings do not settle: segments still cross");
        }
        if (status == PBW_OK) {
            job->plane->report.rounds++;
            status = pbwm2__split(job, &pairs);
            most = most != 0 ? most : 8 * job->segments.count + 256;
        }
        if (status == PBW_OK) {
            status = pbwm2__constrain(job, &crosses);
        }
    }
    PBW_RELEASE(&job->memory, pairs);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>domain       Which triangles belong to the domain.
   In: the constrained triangulation of the convex hull.  Out: regions, their winding numbers; the other triangles are
   removed, and every edge on the border is a constraint.

   A component is a set of triangles connected without crossing a constraint; component 0 is connected to the outside.
   A constraint with one component on both sides, such as a segment that sticks out, separates nothing.  Between two
   components the winding number changes by the pieces on the edge between them, each with its direction.
   ------------------------------------------------------------------------------------------------------ */
#define PBWM2__BORDER (PBW_NONE - 1)       /* an edge that is a constraint because the hull ends there */

static int pbwm2__winding_of(const pbwm2__job *job, pbw_index edge, pbw_index u, pbw_index v)
{
    const int forwards = pbwm2__before(job, u, v);
    int sum = 0;
    while (edge != PBW_NONE) {
        const pbwm2__piece piece = pbwm2__take_piece(job, &edge);
        sum += pbwm2__before(job, piece.a, piece.b) == forwards ? 1 : -1;
    }
    return sum;
}

/* The root of a set, the least of its items.  Halves the path to it (van Leeuwen and van der Weide 1977). */
static pbw_index pbwm2__root(pbw_index *parent, pbw_index item)
{
    while (parent[item] != item) {
        parent[item] = parent[parent[item]];
        item = parent[item];
    }
    return item;
}

/* Joins triangles across free edges: item i + 1 of parent stands for slot i, item 0 for the outside.  The sweep in
   the order of slots stays in the cache; it is branchless in the common case that all earlier neighbours have one
   parent. Marks free edges of the hull as border. */
static void pbwm2__join_components(pbwm2__job *job, pbw_index *parent)
{
    size_t i;
    unsigned k;
    parent[0] = 0;
    for (i = 0; i < job->triangles.count; i++) {
        pbwm2__triangle *t = job->t + i;
        const pbw_index own = (pbw_index)(i + 1);
        pbw_index root = own, before[3], differ = 0;
        parent[own] = own;
        if (t->v[0] == PBW_NONE) {
            continue;
        }
        for (k = 0; k < 3; k++) {
            const pbw_index other = PBWM2__SLOT(t->link[k]) + 1;
            if (t->link[k] == PBW_NONE && t->edge[k] == PBW_NONE) {
                t->edge[k] = PBWM2__BORDER;
                root = 0;
            }
            before[k] = parent[((t->edge[k] == PBW_NONE) & (other < own)) ? other : own];
            root = before[k] < root ? before[k] : root;
        }
        for (k = 0; k < 3; k++) {
            differ |= (pbw_index)((before[k] != root) & (before[k] != own));
        }
        parent[own] = root;
        for (k = 0; differ && k < 3; k++) {
            const pbw_index other = pbwm2__root(parent, before[k]);
            root = pbwm2__root(parent, root);
            parent[other < root ? root : other] = other < root ? other : root;
        }
    }
}

static int pbwm2__add_component(pbwm2__job *job)
{
    pbwm2__component c;
    memset(&c, 0, sizeof c);
    c.seed = PBW_NONE;
    return PBWM2__PUSH(job, job->components, c);
}

static int pbwm2__find_components(pbwm2__job *job)
{
    const size_t n = job->triangles.count;
    pbw_index *parent;
    size_t i;
    job->item_of.count = job->components.count = 0;
    if (!PBWM2__RESERVE(job, job->item_of, n + 1) || !pbwm2__add_component(job)) {
        return 0;
    }
    parent = job->item_of.at;
    pbwm2__join_components(job, parent);
    for (i = 0; i < n; i++) {                        /* parents are numbered before: theirs is a component by now */
        pbwm2__triangle *t = job->t + i;
        if (parent[i + 1] != i + 1) {
            parent[i + 1] = parent[parent[i + 1]];
        } else if (t->v[0] != PBW_NONE) {
            parent[i + 1] = (pbw_index)job->components.count;
            if (!pbwm2__add_component(job)) {
                return 0;
            }
        }
        t->region = parent[i + 1];
    }
    return 1;
}

/* Fills item_of with the codes of the edges of segments, component by component. */
static int pbwm2__list_borders(pbwm2__job *job)
{
    pbwm2__component *c = job->components.at;
    size_t i, sum = 0;
    unsigned k;
    int fill;
    for (fill = 0; fill < 2; fill++) {
        for (i = 0; i < job->triangles.count; i++) {
            const pbwm2__triangle *t = job->t + i;
            for (k = 0; t->v[0] != PBW_NONE && k < 3; k++) {
                if (t->edge[k] < PBWM2__BORDER && fill) {
                    job->item_of.at[c[t->region].first + c[t->region].count++] = (pbw_index)(4 * i + k);
                } else if (t->edge[k] < PBWM2__BORDER) {
                    c[t->region].count++;
                }
            }
        }
        for (i = 0; !fill && i < job->components.count; i++) {
            c[i].first = sum;
            sum += c[i].count;
            c[i].count = 0;
        }
        job->item_of.count = 0;
        if (!PBWM2__RESERVE(job, job->item_of, sum)) {
            return 0;
        }
    }
    job->item_of.count = sum;
    return 1;
}

/* Sets or compares the winding number of a component beyond an edge; 0 if it has another one already. */
static int pbwm2__set_winding(pbwm2__job *job, pbw_index component, int winding)
{
    pbwm2__component *c = job->components.at + component;
    if (!c->known) {
        c->known = 1;
        c->winding = winding;
        job->stack.count++;
        job->stack.at[job->stack.count - 1] = component;
        return 1;
    }
    return c->winding == winding;
}

/* Winding numbers of all components, from 0 outside.  Returns an edge at which they do not agree, PBW_NONE if they
   do. */
static pbw_index pbwm2__wind(pbwm2__job *job)
{
    pbwm2__component *c = job->components.at;
    const pbw_index *item = job->item_of.at;
    size_t at, i;
    job->stack.count = 0;
    (void)pbwm2__set_winding(job, 0, 0);
    for (i = c[0].count; i < job->item_of.count; i++) {      /* hull edges: from outside */
        const pbwm2__triangle *t = job->t + PBWM2__SLOT(item[i]);
        const unsigned k = PBWM2__SIDE(item[i]);
        if (t->link[k] == PBW_NONE && !pbwm2__set_winding(job, t->region,
            pbwm2__winding_of(job, t->edge[k], t->v[pbwm2__next[k]], t->v[pbwm2__last[k]]))) {
            return t->edge[k];
        }
    }
    for (at = 0; at < job->stack.count; at++) {
        const pbw_index here = job->stack.at[at];
        for (i = c[here].first; i < c[here].first + c[here].count; i++) {
            const pbwm2__triangle *t = job->t + PBWM2__SLOT(item[i]);
            const unsigned k = PBWM2__SIDE(item[i]);
            const pbw_index beyond = t->link[k] == PBW_NONE ? here : job->t[PBWM2__SLOT(t->link[k])].region;
            if (beyond != here && !pbwm2__set_winding(job, beyond, c[here].winding
                - pbwm2__winding_of(job, t->edge[k], t->v[pbwm2__next[k]], t->v[pbwm2__last[k]]))) {
                return t->edge[k];
            }
        }
    }
    return PBW_NONE;
}

/* A triangle that contains a point, found from one near it; PBW_NONE outside.  A walk through constrained triangles
   may go round in circles: after too many steps all are searched. */
static pbw_index pbwm2__locate(const pbwm2__job *job, const double *q, pbw_index start)
{
    pbw_index slot = start;
    size_t steps, i;
    unsigned k;
    for (steps = 0; steps < 64 + 8 * job->triangles.count; steps++) {
        for (k = 0; k < 3; k++) {
            const unsigned e = (unsigned)((k + steps) % 3);
            const pbwm2__triangle *t = job->t + slot;
            if (pbwm2__orient_at(job, job->p + 2 * (size_t)t->v[pbwm2__next[e]],
                                 job->p + 2 * (size_t)t->v[pbwm2__last[e]], q) < 0) {
                if (t->link[e] == PBW_NONE) {
                    return PBW_NONE;
                }
                slot = PBWM2__SLOT(t->link[e]);
                break;
            }
        }
        if (k == 3) {
            return slot;
        }
    }
    for (i = 0; i < job->triangles.count; i++) {
        const pbwm2__triangle *t = job->t + i;
        for (k = 0; t->v[0] != PBW_NONE && k < 3; k++) {
            if (pbwm2__orient_at(job, job->p + 2 * (size_t)t->v[pbwm2__next[k]],
                                 job->p + 2 * (size_t)t->v[pbwm2__last[k]], q) < 0) {
                break;
            }
        }
        if (t->v[0] != PBW_NONE && k == 3) {
            return (pbw_index)i;
        }
    }
    return PBW_NONE;
}

/* Marks the components to the left of segments with the numbers that those have.  Where segments on an edge have
   none, the components on both sides are joined, and share the least number. */
static void pbwm2__assign_lefts(pbwm2__job *job)
{
    pbwm2__component *c = job->components.at;
    pbw_index *parent = job->stack.at;
    size_t i;
    unsigned k;
    for (i = 0; i < job->components.count; i++) {
        parent[i] = (pbw_index)i;
    }
    for (i = 0; i < job->triangles.count; i++) {
        const pbwm2__triangle *t = job->t + i;
        for (k = 0; t->v[0] != PBW_NONE && k < 3; k++) {
            pbw_index edge = t->edge[k] != PBWM2__BORDER ? t->edge[k] : PBW_NONE, least = PBW_NONE;
            const int forwards = pbwm2__before(job, t->v[pbwm2__next[k]], t->v[pbwm2__last[k]]);
            while (edge != PBW_NONE) {
                const pbwm2__piece piece = pbwm2__take_piece(job, &edge);
                const pbw_index left = job->input->segment_lefts[piece.segment];
                least = left < least ? left : least;
                c[t->region].seed = pbwm2__before(job, piece.a, piece.b) == forwards && left < c[t->region].seed
                                  ? left : c[t->region].seed;
            }
            if (least == PBW_NONE && t->link[k] != PBW_NONE) {
                const pbw_index one = pbwm2__root(parent, t->region);
                const pbw_index other = pbwm2__root(parent, job->t[PBWM2__SLOT(t->link[k])].region);
                parent[one < other ? other : one] = one < other ? one : other;
            }
        }
    }
    for (i = job->components.count; i-- > 0; ) {     /* parents come before */
        c[parent[i]].seed = c[i].seed < c[parent[i]].seed ? c[i].seed : c[parent[i]].seed;
    }
    for (i = 0; i < job->components.count; i++) {
        c[i].seed = c[parent[i]].seed;
    }
}

/* Marks the components of holes dead, and those of regions with their seed. */
static pbw_status pbwm2__assign_seeds(pbwm2__job *job)
{
    const pbw_plane_input *in = job->input;
    pbwm2__component *c = job->components.at;
    pbw_index slot = 0, found;
    size_t i;
    while (job->t[slot].v[0] == PBW_NONE) {
        slot++;
    }
    if (in->segment_lefts != NULL) {
        pbwm2__assign_lefts(job);
    }
    for (i = 0; i < in->hole_count + in->region_count; i++) {
        const int is_hole = i < in->hole_count;
        double q[2];
        q[0] = is_hole ? in->holes[2 * i] : in->regions[i - in->hole_count].x;
        q[1] = is_hole ? in->holes[2 * i + 1] : in->regions[i - in->hole_count].y;
        if (!(fabs(q[0]) <= 1.7976931348623157e308 && fabs(q[1]) <= 1.7976931348623157e308)) {
            return pbwm2__say(job, PBW_ERROR_NOT_FINITE, "a hole or region is at a place that is not finite");
        }
        found = pbwm2__locate(job, q, slot);
        slot = found == PBW_NONE ? slot : found;
        if (found != PBW_NONE && is_hole) {
            c[job->t[found].region].dead = 1;
        } else if (found != PBW_NONE) {
            c[job->t[found].region].seed = (pbw_index)(i - in->hole_count);
        }
    }
    return PBW_OK;
}

/* Removes the triangles of dead components. */
static void pbwm2__carve(pbwm2__job *job)
{
    const pbwm2__component *c = job->components.at;
    size_t i;
    unsigned k;
    for (i = 0; i < job->triangles.count; i++) {
        const pbwm2__triangle *t = job->t + i;
        if (t->v[0] != PBW_NONE && c[t->region].dead) {
            for (k = 0; k < 3; k++) {
                if (t->link[k] != PBW_NONE) {
                    job->t[PBWM2__SLOT(t->link[k])].link[PBWM2__SIDE(t->link[k])] = PBW_NONE;
                }
            }
            pbwm2__free_slot(job, (pbw_index)i);
        }
    }
    memset(job->incident, 255, job->incidents.count * sizeof *job->incident);
    for (i = 0; i < job->triangles.count; i++) {
        const pbwm2__triangle *t = job->t + i;
        for (k = 0; t->v[0] != PBW_NONE && k < 3; k++) {
            job->incident[t->v[k]] = (pbw_index)i;
        }
    }
}

static pbw_status pbwm2__find_domain(pbwm2__job *job)
{
    const pbw_plane_rule rule = job->options->rule;
    pbwm2__component *c;
    pbw_status status;
    size_t i;
    int dead = 0;
    if (!pbwm2__find_components(job) || (job->stack.count = 0,
        !PBWM2__RESERVE(job, job->stack, job->components.count))) {
        return pbwm2__say(job, PBW_ERROR_MEMORY, NULL);
    }
    if (rule == PBW_PLANE_EVEN_ODD || rule == PBW_PLANE_NONZERO) {
        pbw_index edge;
        if (!pbwm2__list_borders(job)) {
            return pbwm2__say(job, PBW_ERROR_MEMORY, NULL);
        }
        edge = pbwm2__wind(job);
        if (edge != PBW_NONE) {
            snprintf(job->plane->what, sizeof job->plane->what,
                     "the segments do not close, which winding numbers need: see segment %u",
                     (unsigned)pbwm2__id_of(job, pbwm2__take_piece(job, &edge)));
            return PBW_ERROR_ARGUMENT;
        }
    }
    status = pbwm2__assign_seeds(job);
    c = job->components.at;
    for (i = 0; i < job->components.count; i++) {
        c[i].dead |= rule == PBW_PLANE_EVEN_ODD ? c[i].winding % 2 == 0
                   : rule == PBW_PLANE_NONZERO ? c[i].winding == 0 : rule == PBW_PLANE_SEEDS && i == 0;
        dead |= c[i].dead;
    }
    if (status == PBW_OK && dead) {
        pbwm2__carve(job);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>refinement   Refinement: no angle below the bound, no triangle above its size.
   In: the domain.  Out: the domain with more points.
   Holds: after each step it is the constrained Delaunay triangulation of its points and parts of segments.

   Three kinds of work, in this order of precedence:
     segments   that a point in their lens encroaches upon: it sees them at more than 180 - 2 bound degrees
     sizes      triangles that are too large, the last first: a point goes to their circumcentre
     angles     triangles with an angle below the bound, those with the shortest edge first: a corner on no segment
                moves if that mends all triangles at it (Erten and Ungor 2009); else a point goes to the circumcentre,
                or nearer to the shortest edge, where a triangle with just the bound comes out (their off-centre)
   A point that would encroach upon segments, or lies beyond one, is not inserted: one of those segments is split.
   Free points in the diametral circle of a segment are removed before it is split (Chew 1993).  A split goes to the
   place from where the shortest edge of the triangle that asks for it appears at just the bound, if no edge becomes
   shorter than that one; else to the middle.
   It ends: a segment that meets another one at less than 60 degrees is split in the middle, or if one end is of the
   input at a power of two from there, so both are split at the same distance.  A triangle is left alone if its
   shortest edge joins two such points, and so is an angle between two segments (Miller, Pav and Walkington 2003).
   If two segments meet at a sine below 1/32, points of one do not encroach upon the other, as splits at different
   distances would continue down to the distance of the segments; triangles from one to the other are left alone.  No
   split makes an edge shorter than 1e-10 of the domain, and no move one shorter than half of the shortest before, so
   there are finitely many points.  Triangles flatter than that are left alone too, and encroach upon nothing: one ulp
   of a point can bring two segments so close together over their whole length.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwm2__boundary_edge { pbw_index u, v, link, edge, region; } pbwm2__boundary_edge;  /* of a cavity */
enum { PBWM2__CLASSES = 64 };

#define PBWM2__FREE PBW_NONE               /* vertex_host of points in no segment */
#define PBWM2__INPUT (PBW_NONE - 1)        /* of the caller's */

typedef struct pbwm2__refiner {
    pbwm2__job *job;
    double cosine2, lens2, off;            /* squared cosine of the bound, of the lens; off-centre's height */
    double sine, cos, cotan;               /* of the bound and a thousandth of a degree, for places */
    double least2, shortest2;              /* squared least length; of the shortest edge before, halved */
    int classes, has_sizes;                /* exponent of class 0; sizes at vertices are in use */
    double growth;                         /* of sizes, per distance */
    int sizing;                            /* no angle was mended so far: sharp triangles are looked for later */
    uint64_t filled;                       /* bit: that class has triangles */
    pbwm2__indices class_of[PBWM2__CLASSES], large;  /* a slot and a mark each, see queues */
    pbwm2__indices splits;                 /* two ends each */
    pbwm2__indices slots, hits;            /* a cavity: its triangles, segments encroached upon */
    PBW_ARRAY(pbwm2__boundary_edge) boundary;        /* of the cavity */
    pbwm2__indices lowered;                /* vertices with smaller sizes, which may lower their neighbours' */
    size_t inserted, moved, triangle_count;
} pbwm2__refiner;

static pbw_index pbwm2__host_of(const pbwm2__job *job, pbw_index edge)
{
    return job->hosts.count > 0 ? job->hosts.at[edge].edge : edge;
}

static double pbwm2__distance2(const double *a, const double *b)
{
    const double x = a[0] - b[0], y = a[1] - b[1];
    return x * x + y * y;
}

static const double *pbwm2__point(const pbwm2__refiner *r, pbw_index v)
{
    return r->job->p + 2 * (size_t)v;
}

static pbw_index pbwm2__vertex_host(const pbwm2__refiner *r, pbw_index v)
{
    return r->job->vertex_host.at[v];
}

/* Returns whether there was no memory for an array: then all loops end. */
static int pbwm2__failed(const pbwm2__refiner *r)
{
    return r->job->fault != PBW_OK;
}

static void pbwm2__add(pbwm2__refiner *r, pbwm2__indices *array, pbw_index item)
{
    (void)PBWM2__PUSH(r->job, *array, item);
}

/* Returns whether a point is in the lens of the segment u-v. */
static int pbwm2__in_lens(const pbwm2__refiner *r, const double *u, const double *v, const double *p)
{
    const double dot = (u[0] - p[0]) * (v[0] - p[0]) + (u[1] - p[1]) * (v[1] - p[1]);
    return dot < 0 && dot * dot >= r->lens2 * pbwm2__distance2(u, p) * pbwm2__distance2(v, p);
}

/* Returns whether c is nearer to the line a-b than the least length of edges. */
static int pbwm2__is_flat(const pbwm2__refiner *r, const double *a, const double *b, const double *c)
{
    const double twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    return twice * twice < r->least2 * pbwm2__distance2(a, b);
}

/* Returns whether vertex v is on a segment at point z of the input that is not the host's. */
static int pbwm2__is_on_leg(const pbwm2__refiner *r, pbw_index v, pbw_index z, pbw_index host)
{
    const pbwm2__job *job = r->job;
    const pbwm2__host *hosts = job->hosts.at;
    const pbw_index own = pbwm2__vertex_host(r, v);
    pbwm2__spin spin;
    if (own != PBWM2__INPUT) {
        return own != PBWM2__FREE && own != host && (hosts[own].a == z || hosts[own].b == z);
    }
    spin.start = spin.corner = pbwm2__corner_of(job, v);
    spin.clockwise = 0;
    do {
        const pbwm2__triangle *t = job->t + PBWM2__SLOT(spin.corner);
        unsigned k;
        for (k = 1; k < 3; k++) {
            const pbw_index edge = t->edge[(PBWM2__SIDE(spin.corner) + k) % 3];
            if (edge != PBW_NONE && edge != host && (hosts[edge].a == z || hosts[edge].b == z)) {
                return 1;
            }
        }
    } while (pbwm2__spin_on(job, &spin));
    return 0;
}

/* Returns whether side k is an edge of a segment, and corner k is on another one that meets it at a sine below 1/32.
   Conforming meshes have no such exception. */
static int pbwm2__is_narrow(const pbwm2__refiner *r, const pbwm2__triangle *t, unsigned k)
{
    const double *p = pbwm2__point(r, t->v[k]), *u = pbwm2__point(r, t->v[pbwm2__next[k]]);
    const double *v = pbwm2__point(r, t->v[pbwm2__last[k]]);
    const double twice = (v[0] - u[0]) * (p[1] - u[1]) - (v[1] - u[1]) * (p[0] - u[0]);
    const double side2 = pbwm2__distance2(u, v);
    const pbwm2__host *hosts = r->job->hosts.at;
    int end, narrow = 0;
    for (end = 0; r->lens2 > 0 && t->edge[k] != PBW_NONE && end < 2 && !narrow; end++) {
        const pbw_index z = end == 0 ? hosts[t->edge[k]].a : hosts[t->edge[k]].b;
        narrow = 1024 * twice * twice < side2 * pbwm2__distance2(p, pbwm2__point(r, z))
              && pbwm2__is_on_leg(r, t->v[k], z, t->edge[k]);
    }
    return narrow;
}

/* Returns whether the corner across from side k of t, an edge of a segment, encroaches upon it. */
static int pbwm2__encroaches(const pbwm2__refiner *r, const pbwm2__triangle *t, unsigned k)
{
    const double *u = pbwm2__point(r, t->v[pbwm2__next[k]]), *v = pbwm2__point(r, t->v[pbwm2__last[k]]);
    const double *p = pbwm2__point(r, t->v[k]);
    return pbwm2__in_lens(r, u, v, p) && !pbwm2__is_flat(r, u, v, p) && !pbwm2__is_narrow(r, t, k);
}

static int pbwm2__may_split(const pbwm2__refiner *r, pbw_index code)
{
    const unsigned flags = r->job->options->flags;
    const pbwm2__triangle *t = r->job->t + PBWM2__SLOT(code);
    const pbw_index beyond = t->link[PBWM2__SIDE(code)];
    return !r->job->hosts.at[t->edge[PBWM2__SIDE(code)]].stuck
        && (flags & PBW_PLANE_KEEP_SEGMENTS) == 0 && ((flags & PBW_PLANE_KEEP_BOUNDARY) == 0 || beyond != PBW_NONE);
}

/* ---- what is wrong with a triangle */

/* Returns whether u and w are at the same distance from a point of the input, on two segments that meet there at less
   than 60 degrees: at 60 or more, an edge between them is no shorter than that distance, so lengths do not fall. */
static int pbwm2__are_twins(const pbwm2__refiner *r, pbw_index u, pbw_index w)
{
    const pbw_index hu = pbwm2__vertex_host(r, u), hw = pbwm2__vertex_host(r, w);
    const pbwm2__host *host = r->job->hosts.at;
    double one, other;
    pbw_index z;
    if (hu >= PBWM2__INPUT || hw >= PBWM2__INPUT || hu == hw) {
        return 0;
    }
    z = host[hu].a == host[hw].a || host[hu].a == host[hw].b ? host[hu].a
      : host[hu].b == host[hw].a || host[hu].b == host[hw].b ? host[hu].b : PBW_NONE;
    if (z == PBW_NONE) {
        return 0;
    }
    one = pbwm2__distance2(pbwm2__point(r, z), pbwm2__point(r, u));
    other = pbwm2__distance2(pbwm2__point(r, z), pbwm2__point(r, w));
    return fabs(one - other) <= 1e-3 * one && pbwm2__distance2(pbwm2__point(r, u), pbwm2__point(r, w)) < one;
}

/* The edge k of a triangle, squared. */
static double pbwm2__side2(const pbwm2__refiner *r, const pbwm2__triangle *t, unsigned k)
{
    return pbwm2__distance2(pbwm2__point(r, t->v[pbwm2__next[k]]), pbwm2__point(r, t->v[pbwm2__last[k]]));
}

static double pbwm2__least(double a, double b)
{
    return a < b ? a : b;
}

static double pbwm2__most(double a, double b)
{
    return a < b ? b : a;
}

/* Returns whether a triangle has an angle below the bound; squares the length of its shortest edge.  No branches. */
static int pbwm2__is_sharp(const pbwm2__refiner *r, const pbwm2__triangle *t, double *shortest2)
{
    const double a = pbwm2__side2(r, t, 0), b = pbwm2__side2(r, t, 1), c = pbwm2__side2(r, t, 2);
    const double least = pbwm2__least(pbwm2__least(a, b), c);
    const double one = pbwm2__most(a, b), other = pbwm2__most(pbwm2__least(a, b), c), dot = one + other - least;
    *shortest2 = least;
    return dot * dot > 4 * r->cosine2 * one * other;
}

static unsigned pbwm2__shortest(const pbwm2__refiner *r, const pbwm2__triangle *t)
{
    const double a = pbwm2__side2(r, t, 0), b = pbwm2__side2(r, t, 1), c = pbwm2__side2(r, t, 2);
    return a <= b && a <= c ? 0u : b <= c ? 1u : 2u;
}

/* Returns whether no point can mend the small angle: it is between two segments, or the triangle is flat. */
static int pbwm2__is_given(const pbwm2__refiner *r, const pbwm2__triangle *t, unsigned shortest)
{
    const double *a = pbwm2__point(r, t->v[0]), *b = pbwm2__point(r, t->v[1]), *c = pbwm2__point(r, t->v[2]);
    return pbwm2__is_flat(r, a, b, c) || pbwm2__is_flat(r, b, c, a) || pbwm2__is_flat(r, c, a, b)
        || (t->edge[pbwm2__next[shortest]] != PBW_NONE && t->edge[pbwm2__last[shortest]] != PBW_NONE)
        || pbwm2__are_twins(r, t->v[pbwm2__next[shortest]], t->v[pbwm2__last[shortest]])
        || pbwm2__is_narrow(r, t, pbwm2__next[shortest]) || pbwm2__is_narrow(r, t, pbwm2__last[shortest]);
}

static double pbwm2__twice_area(const pbwm2__refiner *r, const pbwm2__triangle *t)
{
    const double *a = pbwm2__point(r, t->v[0]), *b = pbwm2__point(r, t->v[1]), *c = pbwm2__point(r, t->v[2]);
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Returns the most area of a triangle there, 0 = no bound. */
static double pbwm2__area_for(const pbwm2__refiner *r, const pbwm2__triangle *t)
{
    double area = r->job->options->area;
    if (r->job->input->region_count > 0) {
        const pbw_index component = t->region & ~PBWM2__CAVITY;
        const pbw_index seed = r->job->components.at[component].seed;
        const double there = seed < r->job->input->region_count ? r->job->input->regions[seed].area : 0;
        area = there > 0 && (!(area > 0) || there < area) ? there : area;
    }
    return area;
}

/* Returns the most length of an edge there, 0 = no bound.  A function counts at corner k, in the middle if k is 3. */
static double pbwm2__size_for(const pbwm2__refiner *r, const pbwm2__triangle *t, unsigned k)
{
    const pbw_plane_options *o = r->job->options;
    double size = o->size, there;
    if (r->has_sizes) {
        const double *sizes = r->job->sizes.at;
        there = (sizes[t->v[0]] + sizes[t->v[1]] + sizes[t->v[2]]) / 3;
        size = !(size > 0) || there < size ? there : size;
    }
    if (o->size_at != NULL) {
        const double *a = pbwm2__point(r, t->v[k % 3]), *b = pbwm2__point(r, t->v[k < 3 ? k : 1]);
        const double *c = pbwm2__point(r, t->v[k < 3 ? k : 2]);
        there = o->size_at(o->size_user, (a[0] + b[0] + c[0]) / 3, (a[1] + b[1] + c[1]) / 3);
        size = there > 0 && (!(size > 0) || there < size) ? there : size;
    }
    return size;
}

static int pbwm2__is_large(const pbwm2__refiner *r, const pbwm2__triangle *t)
{
    const double area = pbwm2__area_for(r, t);
    double size;
    if (area > 0 && pbwm2__twice_area(r, t) > 2 * area) {
        return 1;
    }
    size = pbwm2__size_for(r, t, 3);
    if (size > 0) {
        const double a = pbwm2__side2(r, t, 0), b = pbwm2__side2(r, t, 1), c = pbwm2__side2(r, t, 2);
        return pbwm2__most(pbwm2__most(a, b), c) > pbwm2__most(size * size, 16 * r->least2);
    }
    return 0;
}

static int pbwm2__class_of(const pbwm2__refiner *r, double length2)
{
    uint64_t bits;
    int exponent;
    memcpy(&bits, &length2, sizeof bits);
    exponent = r->classes - ((int)(bits >> 52) - 1022);          /* as frexp has it */
    return exponent < 0 ? 0 : exponent >= PBWM2__CLASSES ? PBWM2__CLASSES - 1 : exponent;
}

/* ---- queues: most triangles are deleted before their turn; a mark tells whether the slot still has the queued one,
   without reading points */

static pbw_index pbwm2__mark_of(const pbwm2__triangle *t)
{
    return t->v[0] + 2 * t->v[1] + 4 * t->v[2];
}

static void pbwm2__enqueue(pbwm2__refiner *r, pbwm2__indices *queue, pbw_index slot)
{
    pbwm2__add(r, queue, slot);
    pbwm2__add(r, queue, pbwm2__mark_of(r->job->t + slot));
}

/* Takes the last triangle off a queue.  Returns its slot, PBW_NONE if the slot has another triangle by now: that has
   its own entry.  Prefetches the fourth after it, and the points of the second. */
static pbw_index pbwm2__dequeue(const pbwm2__refiner *r, pbwm2__indices *queue)
{
    const pbw_index *item = queue->at + (queue->count -= 2);
    if (queue->count >= 8) {
        const pbwm2__triangle *t = r->job->t + item[-4];
        unsigned k;
        PBW_PREFETCH(r->job->t + item[-8]);
        for (k = 0; k < 3 && t->v[0] != PBW_NONE && pbwm2__mark_of(t) == item[-3]; k++) {
            PBW_PREFETCH(pbwm2__point(r, t->v[k]));
        }
    }
    return r->job->t[item[0]].v[0] != PBW_NONE && pbwm2__mark_of(r->job->t + item[0]) == item[1] ? item[0] : PBW_NONE;
}

/* Puts a triangle where sharp ones wait, if it is one. */
static void pbwm2__examine_angle(pbwm2__refiner *r, pbw_index slot)
{
    double shortest2;
    if (pbwm2__is_sharp(r, r->job->t + slot, &shortest2)) {
        const int c = pbwm2__class_of(r, shortest2);
        pbwm2__enqueue(r, r->class_of + c, slot);
        r->filled |= (uint64_t)1 << c;
    }
}

/* Puts a triangle, and the segments beside it, where the work on them waits. */
static void pbwm2__examine(pbwm2__refiner *r, pbw_index slot)
{
    const pbwm2__triangle *t = r->job->t + slot;
    unsigned k;
    for (k = 0; k < 3; k++) {
        const pbw_index u = t->v[pbwm2__next[k]], v = t->v[pbwm2__last[k]];
        if (t->edge[k] != PBW_NONE && pbwm2__encroaches(r, t, k)) {
            pbwm2__add(r, &r->splits, u);
            pbwm2__add(r, &r->splits, v);
        }
    }
    if (pbwm2__is_large(r, t)) {
        pbwm2__enqueue(r, &r->large, slot);
    }
    if (!r->sizing) {
        pbwm2__examine_angle(r, slot);
    }
}

/* ---- cavities */

static void pbwm2__dig_at(pbwm2__refiner *r, pbw_index slot)
{
    r->job->t[slot].region |= PBWM2__CAVITY;
    pbwm2__add(r, &r->slots, slot);
}

/* Extends the cavity from the triangles in slots to all in conflict with p, without crossing a segment. */
static void pbwm2__dig(pbwm2__refiner *r, const double *p)
{
    pbwm2__job *job = r->job;
    size_t at;
    unsigned k;
    r->boundary.count = 0;
    for (at = 0; at < r->slots.count && !pbwm2__failed(r); at++) {
        const pbw_index slot = r->slots.at[at];
        if (!PBWM2__RESERVE(job, r->boundary, 3)) {
            return;
        }
        for (k = 0; k < 3; k++) {
            const pbwm2__triangle *t = job->t + slot;
            const pbw_index link = t->link[k];
            if (link != PBW_NONE && t->edge[k] == PBW_NONE) {
                const pbwm2__triangle *n = job->t + PBWM2__SLOT(link);
                if ((n->region & PBWM2__CAVITY) != 0) {
                    continue;
                }
                if (pbwm2__conflict_at(job, pbwm2__point(r, n->v[0]), pbwm2__point(r, n->v[1]),
                                       pbwm2__point(r, n->v[2]), p)) {
                    pbwm2__dig_at(r, PBWM2__SLOT(link));
                    continue;
                }
            }
            {
                pbwm2__boundary_edge *side = r->boundary.at + r->boundary.count++;
                side->u = t->v[pbwm2__next[k]];
                side->v = t->v[pbwm2__last[k]];
                side->link = link;
                side->edge = t->edge[k];
                side->region = t->region & ~PBWM2__CAVITY;
            }
        }
    }
}

static void pbwm2__undig(pbwm2__refiner *r)
{
    size_t i;
    for (i = 0; i < r->slots.count; i++) {
        r->job->t[r->slots.at[i]].region &= ~PBWM2__CAVITY;
    }
}

/* Returns whether p sees every edge of the boundary from inside. */
static int pbwm2__is_star(const pbwm2__refiner *r, const double *p)
{
    const pbwm2__boundary_edge *side = r->boundary.at;
    size_t i;
    for (i = 0; i < r->boundary.count; i++) {
        if (pbwm2__orient_at(r->job, p, pbwm2__point(r, side[i].u), pbwm2__point(r, side[i].v)) <= 0) {
            return 0;
        }
    }
    return 1;
}

/* Adds a vertex.  Returns it, PBW_NONE without memory. */
static pbw_index pbwm2__add_vertex(pbwm2__refiner *r, const double *at, pbw_index host, double size)
{
    pbwm2__job *job = r->job;
    const double p[2] = { at[0], at[1] };
    const size_t v = job->points.count;
    (void)(PBWM2__RESERVE(job, job->points, 1) && PBWM2__RESERVE(job, job->incidents, 1)
           && PBWM2__RESERVE(job, job->vertex_host, 1) && (!r->has_sizes || PBWM2__RESERVE(job, job->sizes, 1)));
    job->p = job->points.at[0];                      /* they may be elsewhere, even if others did not grow */
    job->incident = job->incidents.at;
    if (v >= PBWM2__INPUT - 1) {
        job->fault = PBW_ERROR_TOO_LARGE;
    }
    if (pbwm2__failed(r)) {
        return PBW_NONE;
    }
    memcpy(job->points.at[v], p, sizeof p);
    job->incident[v] = PBW_NONE;
    job->vertex_host.at[v] = host;
    if (r->has_sizes) {
        job->sizes.at[v] = size;
        job->sizes.count = v + 1;
    }
    job->points.count = job->incidents.count = job->vertex_host.count = v + 1;
    return (pbw_index)v;
}

/* Replaces an edge by the other diagonal of its two triangles. */
static void pbwm2__flip(pbwm2__job *job, pbw_index code)
{
    const pbw_index slot = PBWM2__SLOT(code), other = PBWM2__SLOT(job->t[slot].link[PBWM2__SIDE(code)]);
    const unsigned e = PBWM2__SIDE(code), f = PBWM2__SIDE(job->t[slot].link[e]);
    pbwm2__triangle *t = job->t + slot, *n = job->t + other;
    const pbwm2__triangle a = *t, b = *n;
    t->v[0] = n->v[0] = a.v[e];
    t->v[1] = a.v[pbwm2__next[e]];
    t->v[2] = n->v[1] = b.v[f];
    n->v[2] = a.v[pbwm2__last[e]];
    t->edge[0] = b.edge[pbwm2__next[f]];
    t->edge[2] = a.edge[pbwm2__last[e]];
    n->edge[0] = b.edge[pbwm2__last[f]];
    n->edge[1] = a.edge[pbwm2__next[e]];
    t->edge[1] = n->edge[2] = PBW_NONE;
    pbwm2__join(job, 4 * slot, b.link[pbwm2__next[f]]);
    pbwm2__join(job, 4 * slot + 2, a.link[pbwm2__last[e]]);
    pbwm2__join(job, 4 * other, b.link[pbwm2__last[f]]);
    pbwm2__join(job, 4 * other + 1, a.link[pbwm2__next[e]]);
    pbwm2__join(job, 4 * slot + 1, 4 * other + 2);
    job->incident[t->v[0]] = job->incident[t->v[1]] = job->incident[t->v[2]] = slot;
    job->incident[n->v[2]] = other;
}

/* Flips free edges of the triangles in slots, and what follows, until all are locally regular (Lawson 1977).  A point
   beside its segment by an ulp can be outside of circles that the cavity takes it to be in. */
static void pbwm2__legalise(pbwm2__refiner *r)
{
    pbwm2__job *job = r->job;
    size_t at;
    unsigned k;
    for (at = 0; at < r->slots.count && !pbwm2__failed(r); at++) {
        const pbw_index slot = r->slots.at[at];
        for (k = 0; k < 3; k++) {
            const pbwm2__triangle *t = job->t + slot;
            const pbw_index link = t->link[k];
            if (t->edge[k] == PBW_NONE && link != PBW_NONE
                && pbwm2__conflict(job, t->v[0], t->v[1], t->v[2], job->t[PBWM2__SLOT(link)].v[PBWM2__SIDE(link)])) {
                pbwm2__flip(job, 4 * slot + k);
                pbwm2__add(r, &r->slots, slot);
                pbwm2__add(r, &r->slots, PBWM2__SLOT(link));
                break;
            }
        }
    }
}

/* Fills the cavity with triangles at vertex p, and examines them.  a, b, edge: the segment that p splits, or
   PBW_NONE. */
static int pbwm2__refill_star(pbwm2__refiner *r, pbw_index p, pbw_index a, pbw_index b, pbw_index edge)
{
    pbwm2__job *job = r->job;
    const size_t count = r->boundary.count;
    size_t i;
    if (!pbwm2__reserve_slots(job, count)) {
        return 0;
    }
    r->triangle_count += count - r->slots.count;
    for (i = 0; i < r->slots.count; i++) {
        pbwm2__free_slot(job, r->slots.at[i]);
    }
    r->slots.count = 0;
    for (i = 0; i < count; i++) {
        const pbwm2__boundary_edge side = r->boundary.at[i];
        const pbw_index slot = pbwm2__take_slot(job);
        pbwm2__triangle *t = job->t + slot;
        t->v[0] = p;
        t->v[1] = side.u;
        t->v[2] = side.v;
        t->edge[0] = side.edge;
        t->edge[1] = side.v == a || side.v == b ? edge : PBW_NONE;
        t->edge[2] = side.u == a || side.u == b ? edge : PBW_NONE;
        t->link[1] = t->link[2] = PBW_NONE;
        t->region = side.region;
        pbwm2__join(job, 4 * slot, side.link);
        job->incident[side.u] = slot;
        job->incident[p] = slot;
        pbwm2__add(r, &r->slots, slot);
    }
    for (i = 0; i < count && !pbwm2__failed(r); i++) {
        const pbw_index slot = r->slots.at[i], next = job->incident[job->t[slot].v[2]];
        if (job->t[next].v[0] == p && job->t[next].v[1] == job->t[slot].v[2]) {
            pbwm2__join(job, 4 * slot + 1, 4 * next + 2);
        } else {
            job->incident[job->t[slot].v[2]] = slot;     /* the border ends here */
        }
    }
    if (edge != PBW_NONE) {
        pbwm2__legalise(r);
    }
    for (i = 0; i < r->slots.count && !pbwm2__failed(r); i++) {
        pbwm2__examine(r, r->slots.at[i]);
    }
    r->inserted++;
    return 1;
}

/* ---- removing a vertex */

/* Returns whether the new triangles are positive and locally regular. */
static int pbwm2__is_good_fill(const pbwm2__job *job)
{
    size_t i;
    unsigned k;
    for (i = 0; i < job->fresh.count; i++) {
        const pbwm2__triangle *t = job->t + job->fresh.at[i];
        if (pbwm2__orient(job, t->v[0], t->v[1], t->v[2]) <= 0) {
            return 0;
        }
    }
    for (i = 0; i < job->fresh.count; i++) {
        const pbwm2__triangle *t = job->t + job->fresh.at[i];
        for (k = 0; k < 3; k++) {
            if (t->edge[k] == PBW_NONE && pbwm2__conflict(job, t->v[0], t->v[1], t->v[2],
                job->t[PBWM2__SLOT(t->link[k])].v[PBWM2__SIDE(t->link[k])])) {
                return 0;
            }
        }
    }
    return 1;
}

/* Removes a free vertex.  Returns 0, with nothing changed, if that is impossible or there is no memory. */
static int pbwm2__remove(pbwm2__refiner *r, pbw_index vertex)
{
    pbwm2__job *job = r->job;
    const pbw_index start = pbwm2__corner_of(job, vertex);
    pbw_index corner = start, base = PBW_NONE, region = job->t[PBWM2__SLOT(start)].region;
    pbwm2__joint *chain;
    size_t i, count;
    int good;
    job->chain[0].count = job->old.count = job->fresh.count = 0;
    do {
        const pbwm2__triangle *t = job->t + PBWM2__SLOT(corner);
        const unsigned k = PBWM2__SIDE(corner);
        if (t->edge[pbwm2__next[k]] != PBW_NONE || !pbwm2__chain_push(job, 0, t->v[pbwm2__next[k]], corner)
            || !PBWM2__PUSH(job, job->old, PBWM2__SLOT(corner))) {
            return 0;
        }
        corner = pbwm2__round(job, corner, 0);
    } while (corner != start);
    count = job->chain[0].count;
    chain = job->chain[0].at;
    if (!pbwm2__reserve_slots(job, count)) {
        return 0;
    }
    for (i = 0; i < count; i++) {                    /* old triangles stay until the new are known to be good */
        const pbwm2__triangle *t = job->t + PBWM2__SLOT(chain[i].link);
        chain[i].slot = PBW_NONE;
        chain[i].edge = t->edge[PBWM2__SIDE(chain[i].link)];
        chain[i].link = t->link[PBWM2__SIDE(chain[i].link)];
    }
    pbwm2__reverse(chain, count);
    base = pbwm2__fill(job, chain, count, region);
    good = base != PBW_NONE;
    if (good) {
        job->t[PBWM2__SLOT(base)].edge[PBWM2__SIDE(base)] = chain[count - 1].edge;
        pbwm2__join(job, base, chain[count - 1].link);
        good = pbwm2__is_good_fill(job);
    }
    if (!good) {                                     /* the old triangles are still there: link them again */
        for (i = 0; i < job->fresh.count; i++) {
            pbwm2__free_slot(job, job->fresh.at[i]);
        }
        for (corner = start, i = 0; i < count; i++) {
            const pbwm2__triangle *t = job->t + PBWM2__SLOT(corner);
            pbwm2__join(job, corner, t->link[PBWM2__SIDE(corner)]);
            job->incident[t->v[pbwm2__next[PBWM2__SIDE(corner)]]] = PBWM2__SLOT(corner);
            corner = pbwm2__round(job, corner, 0);
        }
        return 0;
    }
    for (i = 0; i < count; i++) {
        pbwm2__free_slot(job, job->old.at[i]);
    }
    job->incident[vertex] = PBW_NONE;
    job->plane->report.removed++;
    r->triangle_count -= count - job->fresh.count;
    for (i = 0; i < job->fresh.count; i++) {
        pbwm2__examine(r, job->fresh.at[i]);
    }
    return 1;
}

/* Removes free vertices that see an edge of a segment at an angle above 90 degrees. */
static void pbwm2__clear(pbwm2__refiner *r, pbw_index u, pbw_index v)
{
    pbwm2__job *job = r->job;
    int more = job->plane->report.removed / 4 < job->points.count + 250, side;   /* an end, however numbers round */
    while (more && !pbwm2__failed(r)) {
        pbw_index code = pbwm2__find_edge(job, u, v);
        more = 0;
        for (side = 0; side < 2 && code != PBW_NONE && !more; side++) {
            const pbw_index x = job->t[PBWM2__SLOT(code)].v[PBWM2__SIDE(code)];
            const double *a = pbwm2__point(r, u), *b = pbwm2__point(r, v), *p = pbwm2__point(r, x);
            more = pbwm2__vertex_host(r, x) == PBWM2__FREE
                && (a[0] - p[0]) * (b[0] - p[0]) + (a[1] - p[1]) * (b[1] - p[1]) < 0 && pbwm2__remove(r, x);
            code = more ? code : job->t[PBWM2__SLOT(code)].link[PBWM2__SIDE(code)];
        }
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>steps        Steps of refinement: sizes at vertices, splits of segments, moves and insertions of points.
   In: the state and the tools of the section before.  Out: a segment split, a triangle mended.
   Holds: what that section says.
   ------------------------------------------------------------------------------------------------------ */

/* ---- sizes at vertices */

/* Returns the size for the edges of a region: the longest edge of a triangle with angles of 30 degrees and the
   region's area, so that sizes grow from there, and no triangle in the region becomes smaller. */
static double pbwm2__size_of_region(const pbwm2__refiner *r, const pbwm2__triangle *t)
{
    const pbwm2__job *job = r->job;
    const pbwm2__component *c = job->components.at + (t->region & ~PBWM2__CAVITY);
    const double area = c->seed < job->input->region_count && job->options->gradation > 0
                      ? job->input->regions[c->seed].area : 0;
    return area > 0 ? 2.6321480259049848 * sqrt(area) : 1e60;          /* 2 * 3^(1/4) */
}

static double pbwm2__size_at(const pbwm2__refiner *r, pbw_index v)
{
    const pbw_plane_options *o = r->job->options;
    const double *p = pbwm2__point(r, v);
    const double size = o->gradation > 0 && o->size_at != NULL ? o->size_at(o->size_user, p[0], p[1]) : 0;
    return size > 0 ? size : 1e60;
}

/* During refinement, ignores a fall of less than a twentieth: each new vertex makes paths slightly shorter. */
static void pbwm2__lower(pbwm2__refiner *r, pbw_index v, double size)
{
    double *sizes = r->job->sizes.at;
    if (size < (r->inserted > 0 ? 0.95 : 1) * sizes[v]) {
        sizes[v] = size;
        pbwm2__add(r, &r->lowered, v);
    }
}

/* Spreads lowered sizes to neighbours, and on, within the growth per distance.  It ends, as no size lowers itself.
   During refinement, examines the triangles there again. */
static void pbwm2__spread(pbwm2__refiner *r)
{
    const pbwm2__job *job = r->job;
    size_t at;
    unsigned k;
    for (at = 0; at < r->lowered.count && !pbwm2__failed(r); at++) {
        const pbw_index v = r->lowered.at[at];
        pbwm2__spin spin;
        spin.start = spin.corner = pbwm2__corner_of(job, v);
        spin.clockwise = 0;
        do {
            const pbwm2__triangle *t = job->t + PBWM2__SLOT(spin.corner);
            for (k = 0; k < 3; k++) {
                const double apart = sqrt(pbwm2__distance2(pbwm2__point(r, v), pbwm2__point(r, t->v[k])));
                pbwm2__lower(r, t->v[k], job->sizes.at[v] + r->growth * apart);
            }
            if (r->inserted > 0 && pbwm2__is_large(r, t)) {
                pbwm2__enqueue(r, &r->large, PBWM2__SLOT(spin.corner));
            }
        } while (pbwm2__spin_on(job, &spin));
    }
    r->lowered.count = 0;
}

/* Lowers the size of a new vertex to the bounds by its neighbours, its region and its place.  Returns 1, for its
   callers. */
static int pbwm2__grade(pbwm2__refiner *r, pbw_index v)
{
    const pbwm2__job *job = r->job;
    double *sizes = job->sizes.at, most;
    pbwm2__spin spin;
    unsigned k;
    if (!r->has_sizes) {
        return 1;
    }
    most = pbwm2__size_at(r, v);
    spin.start = spin.corner = pbwm2__corner_of(job, v);
    spin.clockwise = 0;
    do {
        const pbwm2__triangle *t = job->t + PBWM2__SLOT(spin.corner);
        most = fmin(most, pbwm2__size_of_region(r, t));
        for (k = 0; k < 3; k++) {
            const double apart = sqrt(pbwm2__distance2(pbwm2__point(r, v), pbwm2__point(r, t->v[k])));
            most = fmin(most, sizes[t->v[k]] + r->growth * apart);
        }
    } while (pbwm2__spin_on(job, &spin));
    if (most < sizes[v]) {
        sizes[v] = most;
        pbwm2__add(r, &r->lowered, v);
        pbwm2__spread(r);
    }
    return 1;
}

/* ---- splitting a segment */

/* Where to split u-v: in the middle; or, if just one end is of the input, at a power of two from it, between one
   third and two thirds. */
static double pbwm2__where(const pbwm2__refiner *r, pbw_index u, pbw_index v, double out[2])
{
    const int u_given = pbwm2__vertex_host(r, u) == PBWM2__INPUT, v_given = pbwm2__vertex_host(r, v) == PBWM2__INPUT;
    const double *a = pbwm2__point(r, u), *b = pbwm2__point(r, v);
    double at = 0.5;
    int exponent;
    if (u_given != v_given) {
        const double length = sqrt(pbwm2__distance2(a, b));
        const double part = frexp(length, &exponent);            /* 1/2 .. 1 */
        const double power = ldexp(part < 0.75 ? 0.25 : 0.5, exponent);
        at = u_given ? power / length : 1 - power / length;
    }
    out[0] = a[0] + at * (b[0] - a[0]);
    out[1] = a[1] + at * (b[1] - a[1]);
    return at;
}

/* Finds where p and q appear at the bound from u-v: of two such places the one farther from all four, if it is not
   nearer to them than they are to each other.  It lies to the left of p-q.  Returns the squared distance of p and q,
   or 0 if there is no such place. */
static double pbwm2__aim(const pbwm2__refiner *r, const pbw_index end[4], double *at, double out[2])
{
    const double *u = pbwm2__point(r, end[0]), *v = pbwm2__point(r, end[1]);
    const double *p = pbwm2__point(r, end[2]), *q = pbwm2__point(r, end[3]);
    const double x = q[0] - p[0], y = q[1] - p[1], apart2 = x * x + y * y;
    const double dx = v[0] - u[0], dy = v[1] - u[1], d2 = dx * dx + dy * dy;
    /* The circle of all such places, its centre relative to u. */
    const double cx = p[0] - u[0] + 0.5 * (x - r->cotan * y), cy = p[1] - u[1] + 0.5 * (y + r->cotan * x);
    const double off = cx * dy - cy * dx, half2 = (apart2 / (4 * r->sine * r->sine) - off * off / d2) / d2;
    const double middle = (cx * dx + cy * dy) / d2, half = half2 > 0 ? sqrt(half2) : 0;
    double best = 0;
    int k, i;
    for (k = -1; k < 2; k += 2) {
        const double t = middle + k * half, place[2] = { u[0] + t * dx, u[1] + t * dy };
        double near2 = t > 0 && t < 1 ? pbwm2__distance2(place, u) : 0;
        for (i = 1; i < 4; i++) {
            near2 = pbwm2__least(near2, pbwm2__distance2(place, pbwm2__point(r, end[i])));
        }
        if (near2 > best) {
            best = near2;
            *at = t;
            memcpy(out, place, sizeof place);
        }
    }
    return half2 > 0 && best >= 0.98 * apart2 ? apart2 : 0;
}

/* Digs the cavity of a point on an edge, which is not of its boundary.  Returns the squared distance of the nearest
   vertex round it. */
static double pbwm2__dig_edge(pbwm2__refiner *r, pbw_index code, const double *point)
{
    const pbwm2__triangle *t = r->job->t + PBWM2__SLOT(code);
    const pbw_index beyond = t->link[PBWM2__SIDE(code)];
    const pbw_index u = t->v[pbwm2__next[PBWM2__SIDE(code)]], v = t->v[pbwm2__last[PBWM2__SIDE(code)]];
    double least = HUGE_VAL;
    size_t i, kept = 0;
    r->slots.count = 0;
    pbwm2__dig_at(r, PBWM2__SLOT(code));
    if (beyond != PBW_NONE) {
        pbwm2__dig_at(r, PBWM2__SLOT(beyond));
    }
    pbwm2__dig(r, point);
    for (i = 0; i < r->boundary.count; i++) {
        const pbwm2__boundary_edge side = r->boundary.at[i];
        least = pbwm2__least(least, pbwm2__distance2(point, pbwm2__point(r, side.u)));
        if ((side.u != u || side.v != v) && (side.u != v || side.v != u)) {
            r->boundary.at[kept++] = side;
        }
    }
    r->boundary.count = kept;
    return least;
}

/* Digs the cavity of the point where u-v is to be split.  base: the edge of a triangle that this is to mend; NULL: of
   the triangle beside u-v with a corner in the lens.  Returns where the point is, as a part of u-v. */
static double pbwm2__dig_split(pbwm2__refiner *r, pbw_index code, const pbw_index *base, double point[2])
{
    const pbwm2__job *job = r->job;
    const pbwm2__triangle *t = job->t + PBWM2__SLOT(code);
    const pbw_index beyond = t->link[PBWM2__SIDE(code)];
    unsigned k = PBWM2__SIDE(code);
    pbw_index end[4] = { t->v[pbwm2__next[k]], t->v[pbwm2__last[k]], 0, 0 };
    double at = 0, apart2 = 0;
    const int acute = job->hosts.at[t->edge[k]].acute;
    if (base != NULL) {
        memcpy(end + 2, base, 2 * sizeof *base);
    } else {
        if (beyond != PBW_NONE && !pbwm2__encroaches(r, t, k)) {
            t = job->t + PBWM2__SLOT(beyond);
            k = PBWM2__SIDE(beyond);
        }
        k = pbwm2__side2(r, t, pbwm2__next[k]) < pbwm2__side2(r, t, pbwm2__last[k]) ? pbwm2__next[k] : pbwm2__last[k];
        end[2] = t->v[pbwm2__next[k]];               /* the shorter of the other two sides */
        end[3] = t->v[pbwm2__last[k]];
    }
    apart2 = acute ? 0 : pbwm2__aim(r, end, &at, point);
    if (apart2 > 0) {
        if (pbwm2__dig_edge(r, code, point) >= 0.97 * apart2) {
            return at;
        }
        pbwm2__undig(r);
    }
    at = pbwm2__where(r, end[0], end[1], point);
    (void)pbwm2__dig_edge(r, code, point);
    return at;
}

/* Splits an edge of a segment for a triangle with this base, or if base is NULL only if a corner beside it lies in
   its lens.  Returns whether it did. */
static int pbwm2__split_edge(pbwm2__refiner *r, pbw_index u, pbw_index v, const pbw_index *base)
{
    pbwm2__job *job = r->job;
    pbw_index code = pbwm2__find_edge(job, u, v), beyond, edge, p;
    double at, point[2], size = 0;
    if (code == PBW_NONE || job->t[PBWM2__SLOT(code)].edge[PBWM2__SIDE(code)] == PBW_NONE
        || !pbwm2__may_split(r, code)) {
        return 0;
    }
    beyond = job->t[PBWM2__SLOT(code)].link[PBWM2__SIDE(code)];
    if (base == NULL && !pbwm2__encroaches(r, job->t + PBWM2__SLOT(code), PBWM2__SIDE(code))
        && (beyond == PBW_NONE || !pbwm2__encroaches(r, job->t + PBWM2__SLOT(beyond), PBWM2__SIDE(beyond)))) {
        return 0;
    }
    if (pbwm2__distance2(pbwm2__point(r, u), pbwm2__point(r, v)) < 16 * r->least2) {
        job->plane->report.short_edges++;
        return 0;
    }
    pbwm2__clear(r, u, v);
    code = pbwm2__find_edge(job, u, v);
    edge = job->t[PBWM2__SLOT(code)].edge[PBWM2__SIDE(code)];
    u = job->t[PBWM2__SLOT(code)].v[pbwm2__next[PBWM2__SIDE(code)]];
    v = job->t[PBWM2__SLOT(code)].v[pbwm2__last[PBWM2__SIDE(code)]];
    at = pbwm2__dig_split(r, code, base, point);
    if (pbwm2__failed(r) || !pbwm2__is_star(r, point)) {
        pbwm2__undig(r);
        job->hosts.at[edge].stuck = 1;
        job->plane->report.short_edges++;
        return 0;
    }
    if (r->has_sizes) {
        size = (1 - at) * job->sizes.at[u] + at * job->sizes.at[v];
    }
    p = pbwm2__add_vertex(r, point, edge, size);
    return p != PBW_NONE && pbwm2__refill_star(r, p, u, v, edge) && pbwm2__grade(r, p);
}

/* ---- moving a vertex */

enum { PBWM2__RING = 12 };                 /* most neighbours of a vertex that moves */

/* An edge across from a vertex, from x, y in the direction along; and what places have triangles on it with angles of
   the bound: above two lines through its ends, and in a circle. */
typedef struct pbwm2__base { double x, y, along[2], length, height, radius; } pbwm2__base;

/* Returns whether two triangles with angles of the bound fit into the angle at b of a ring, counter-clockwise. */
static int pbwm2__is_wide(const pbwm2__refiner *r, const double *a, const double *b, const double *c)
{
    const double ax = a[0] - b[0], ay = a[1] - b[1], cx = c[0] - b[0], cy = c[1] - b[1];
    const double dot = ax * cx + ay * cy, twice = 1 - 2 * r->sine * r->sine;          /* cosine of twice the bound */
    return dot <= 0 || cx * ay <= cy * ax || dot * dot <= twice * twice * (ax * ax + ay * ay) * (cx * cx + cy * cy);
}

/* Fills ring with the neighbours of a free vertex, counter-clockwise.  Returns their number; 0 if they are too many,
   or if two triangles do not fit at one of them. */
static size_t pbwm2__find_ring(const pbwm2__refiner *r, pbw_index v, const double *ring[PBWM2__RING + 2])
{
    const pbw_index start = pbwm2__corner_of(r->job, v);
    pbw_index corner = start;
    size_t n = 0, i;
    do {
        ring[n++] = pbwm2__point(r, r->job->t[PBWM2__SLOT(corner)].v[pbwm2__next[PBWM2__SIDE(corner)]]);
        if (n > PBWM2__RING || (n > 2 && !pbwm2__is_wide(r, ring[n - 3], ring[n - 2], ring[n - 1]))) {
            return 0;
        }
        corner = pbwm2__round(r->job, corner, 0);
    } while (corner != start);
    for (i = 0; i < 2; i++) {                        /* the ring goes on as it began */
        ring[n + i] = ring[i];
        if (!pbwm2__is_wide(r, ring[n + i - 2], ring[n + i - 1], ring[n + i])) {
            return 0;
        }
    }
    return n;
}

/* Returns by how much a place misses the bound in the triangle on a base, at most 0 if it does not; step: the way
   there. */
static double pbwm2__miss(const pbwm2__refiner *r, const pbwm2__base *base, const double *p, double step[2])
{
    const double px = p[0] - base->x, py = p[1] - base->y;
    const double x = px * base->along[0] + py * base->along[1], y = py * base->along[0] - px * base->along[1];
    const double from_left = x * r->sine - y * r->cos, from_right = (base->length - x) * r->sine - y * r->cos;
    const double cx = 0.5 * base->length - x, cy = base->height - y, centre2 = cx * cx + cy * cy;
    double most = from_left, sx = -r->sine, sy = r->cos;
    if (from_right > most) {
        most = from_right;
        sx = r->sine;
    }
    if (centre2 > base->radius * base->radius) {
        const double centre = sqrt(centre2);
        if (centre - base->radius > most) {
            most = centre - base->radius;
            sx = cx / centre;
            sy = cy / centre;
        }
    }
    step[0] = most * (sx * base->along[0] - sy * base->along[1]);
    step[1] = most * (sx * base->along[1] + sy * base->along[0]);
    return most;
}

/* Moves a place until all triangles from it to a ring have angles of the bound: the places for one triangle are a
   convex set, and each step goes to the nearest place of the set that is missed most, and a third farther (Agmon
   1954).  Returns 0 if five steps do not suffice, or none was needed. */
static int pbwm2__find_place(const pbwm2__refiner *r, const double *const *ring, size_t n, double p[2])
{
    pbwm2__base base[PBWM2__RING];
    size_t i;
    int steps;
    for (i = 0; i < n; i++) {
        const double *a = ring[i], *b = ring[i + 1];
        base[i].length = sqrt(pbwm2__distance2(a, b));
        base[i].x = a[0];
        base[i].y = a[1];
        base[i].along[0] = (b[0] - a[0]) / base[i].length;
        base[i].along[1] = (b[1] - a[1]) / base[i].length;
        base[i].height = 0.5 * base[i].length * r->cotan;
        base[i].radius = 0.5 * base[i].length / r->sine;
    }
    for (steps = 0; steps < 6; steps++) {
        double most = 0, step[2] = { 0, 0 }, one[2];
        for (i = 0; i < n; i++) {
            const double miss = pbwm2__miss(r, base + i, p, one);
            if (miss > most) {
                most = miss;
                memcpy(step, one, sizeof one);
            }
        }
        if (!(most > 0)) {
            return steps > 0;
        }
        p[0] += 4.0 / 3 * step[0];
        p[1] += 4.0 / 3 * step[1];
    }
    return 0;
}

/* Returns whether the triangles of a star are all as wanted, and no corner of the ring is near. */
static int pbwm2__is_mended(const pbwm2__refiner *r)
{
    size_t i;
    unsigned k;
    double unused;
    for (i = 0; i < r->slots.count; i++) {
        const pbwm2__triangle *t = r->job->t + r->slots.at[i];
        if (pbwm2__orient(r->job, t->v[0], t->v[1], t->v[2]) <= 0 || pbwm2__is_sharp(r, t, &unused)
            || pbwm2__is_large(r, t)) {
            return 0;
        }
        for (k = 0; k < 3; k++) {
            if (pbwm2__side2(r, t, k) < r->shortest2 || (t->edge[k] != PBW_NONE && pbwm2__encroaches(r, t, k))) {
                return 0;
            }
        }
    }
    return 1;
}

/* Moves a free vertex so that all its triangles are as wanted.  Returns 0, with nothing changed, if it found no
   place. */
static int pbwm2__move(pbwm2__refiner *r, pbw_index v)
{
    pbwm2__job *job = r->job;
    const double *ring[PBWM2__RING + 2];
    double *p = job->p + 2 * (size_t)v, place[2], old[2];
    pbw_index start, corner;
    size_t n, i;
    if (pbwm2__vertex_host(r, v) != PBWM2__FREE || r->moved / 4 > job->points.count + 250) { /* an end, as in clear */
        return 0;
    }
    memcpy(place, p, sizeof place);
    memcpy(old, p, sizeof old);
    n = pbwm2__find_ring(r, v, ring);
    if (n == 0 || !pbwm2__find_place(r, ring, n, place)) {
        return 0;
    }
    memcpy(p, place, sizeof place);
    r->slots.count = 0;
    start = corner = pbwm2__corner_of(job, v);
    do {
        pbwm2__add(r, &r->slots, PBWM2__SLOT(corner));
        corner = pbwm2__round(job, corner, 0);
    } while (corner != start);
    if (!pbwm2__is_mended(r)) {
        memcpy(p, old, sizeof old);
        return 0;
    }
    pbwm2__legalise(r);
    for (i = 0; i < r->slots.count && !pbwm2__failed(r); i++) {
        pbwm2__examine(r, r->slots.at[i]);
    }
    r->moved++;
    return pbwm2__grade(r, v);
}

/* ---- mending a triangle */

/* The place for a new point: the circumcentre, or nearer to the shortest edge. */
static void pbwm2__centre(const pbwm2__refiner *r, const pbwm2__triangle *t, unsigned shortest, double out[2])
{
    const double *o = pbwm2__point(r, t->v[pbwm2__next[shortest]]), *d = pbwm2__point(r, t->v[pbwm2__last[shortest]]);
    const double *a = pbwm2__point(r, t->v[shortest]);
    const double dx = d[0] - o[0], dy = d[1] - o[1], ax = a[0] - o[0], ay = a[1] - o[1];
    const double a2 = ax * ax + ay * ay, det = 2 * (dx * ay - dy * ax);
    /* The centre is on the line through the middle of o-d, at height times its length on the left. */
    const double height = (a2 - (ax * dx + ay * dy)) / det;
    const double h = height < r->off ? height : r->off;
    out[0] = o[0] + 0.5 * dx - h * dy;
    out[1] = o[1] + 0.5 * dy + h * dx;
}

/* Walks from a triangle towards a point.  Returns the triangle that has it; or PBW_NONE, with the ends of the segment
   in the way in hits if there is one. */
static pbw_index pbwm2__walk(pbwm2__refiner *r, pbw_index slot, const double *p)
{
    pbwm2__job *job = r->job;
    pbw_index from = PBW_NONE;
    int steps;
    unsigned k;
    for (steps = 0; steps < 10000; steps++) {
        const pbwm2__triangle *t = job->t + slot;
        for (k = 0; k < 3; k++) {
            const pbw_index u = t->v[pbwm2__next[k]], v = t->v[pbwm2__last[k]];
            if (t->link[k] != PBW_NONE && PBWM2__SLOT(t->link[k]) == from) {
                continue;
            }
            if (pbwm2__orient_at(job, pbwm2__point(r, u), pbwm2__point(r, v), p) < 0) {
                if (t->edge[k] != PBW_NONE) {
                    pbwm2__add(r, &r->hits, u);
                    pbwm2__add(r, &r->hits, v);
                    return PBW_NONE;
                }
                from = slot;
                slot = PBWM2__SLOT(t->link[k]);
                break;
            }
        }
        if (k == 3) {
            return slot;
        }
    }
    return PBW_NONE;
}

static double pbwm2__size_in(const pbwm2__refiner *r, const pbwm2__triangle *t, const double *p)
{
    double weight[3], sum = 0, size = 0;
    unsigned k;
    for (k = 0; k < 3; k++) {
        const double *a = pbwm2__point(r, t->v[pbwm2__next[k]]), *b = pbwm2__point(r, t->v[pbwm2__last[k]]);
        weight[k] = fabs((a[0] - p[0]) * (b[1] - p[1]) - (a[1] - p[1]) * (b[0] - p[0]));
        sum += weight[k];
    }
    for (k = 0; k < 3 && sum > 0; k++) {
        size += weight[k] / sum * r->job->sizes.at[t->v[k]];
    }
    return size;
}

/* Inserts a point for a triangle, or splits a segment that is in its way.  Returns whether either was done. */
static int pbwm2__mend(pbwm2__refiner *r, pbw_index slot, unsigned shortest)
{
    pbwm2__job *job = r->job;
    const pbw_index base[2] = { job->t[slot].v[pbwm2__next[shortest]], job->t[slot].v[pbwm2__last[shortest]] };
    double point[2], size = 0;
    pbw_index found, p;
    size_t i;
    int done = 0;
    r->hits.count = r->slots.count = 0;
    pbwm2__centre(r, job->t + slot, shortest, point);
    if (!(fabs(point[0]) < 1e70 && fabs(point[1]) < 1e70)) {
        return 0;
    }
    found = pbwm2__walk(r, slot, point);
    if (found != PBW_NONE) {
        pbwm2__dig_at(r, found);
        pbwm2__dig(r, point);
        for (i = 0; i < r->boundary.count; i++) {
            const pbwm2__boundary_edge side = r->boundary.at[i];
            if (side.edge != PBW_NONE && pbwm2__in_lens(r, pbwm2__point(r, side.u), pbwm2__point(r, side.v), point)) {
                pbwm2__add(r, &r->hits, side.u);
                pbwm2__add(r, &r->hits, side.v);
            }
        }
        if (r->hits.count == 0 && !pbwm2__failed(r) && pbwm2__is_star(r, point)) {
            size = r->has_sizes ? pbwm2__size_in(r, job->t + found, point) : 0;
            p = pbwm2__add_vertex(r, point, PBWM2__FREE, size);
            return p != PBW_NONE && pbwm2__refill_star(r, p, PBW_NONE, PBW_NONE, PBW_NONE) && pbwm2__grade(r, p);
        }
        pbwm2__undig(r);
    }
    for (i = 0; i < r->hits.count && !done && !pbwm2__failed(r); i += 2) {
        done = pbwm2__split_edge(r, r->hits.at[i], r->hits.at[i + 1], base);
    }
    if (done && job->t[slot].v[0] != PBW_NONE) {
        pbwm2__examine(r, slot);                     /* it may be as bad as before */
    }
    return done;
}

/* ------------------------------------------------------------------------------------------------------
   >>loop         The loop of refinement.
   In: the domain, the steps of the section before.  Out: the refined domain, or that it would have too many
   triangles.
   Holds: what the first of these sections says.
   ------------------------------------------------------------------------------------------------------ */
static void pbwm2__mend_sharp(pbwm2__refiner *r)
{
    double shortest2;
    pbw_index slot;
    int c = PBWM2__CLASSES - 1;
    while ((r->filled >> c & 1) == 0) {
        c--;
    }
    slot = pbwm2__dequeue(r, r->class_of + c);
    if (r->class_of[c].count == 0) {
        r->filled &= ~((uint64_t)1 << c);
    }
    if (slot != PBW_NONE && pbwm2__is_sharp(r, r->job->t + slot, &shortest2) && shortest2 > r->least2) {
        const pbwm2__triangle *t = r->job->t + slot;
        const unsigned shortest = pbwm2__shortest(r, t);
        if (!pbwm2__is_given(r, t, shortest) && !pbwm2__move(r, t->v[shortest])
            && !pbwm2__move(r, t->v[pbwm2__next[shortest]]) && !pbwm2__move(r, t->v[pbwm2__last[shortest]])) {
            pbwm2__mend(r, slot, shortest);
        }
    }
}

static void pbwm2__mend_large(pbwm2__refiner *r)
{
    const pbw_index slot = pbwm2__dequeue(r, &r->large);
    if (slot != PBW_NONE && pbwm2__is_large(r, r->job->t + slot)) {
        const pbwm2__triangle *t = r->job->t + slot;
        const unsigned shortest = pbwm2__shortest(r, t);
        if (pbwm2__side2(r, t, shortest) > r->least2) {
            pbwm2__mend(r, slot, shortest);
        }
    }
}

/* How far refinement is, which nobody knows before it ends. */
static double pbwm2__refined(const pbwm2__refiner *r)
{
    return 1 - 1 / (1 + 1e-5 * (double)r->inserted);
}

/* Queues the sharp triangles once no triangle is too large; most earlier ones have been deleted by then. */
static void pbwm2__begin_angles(pbwm2__refiner *r)
{
    double least2 = HUGE_VAL, shortest2;
    size_t i;
    r->sizing = 0;
    for (i = r->job->triangles.count; i > 0 && !pbwm2__failed(r); i--) {  /* stacks: the first come out first */
        if (r->job->t[i - 1].v[0] != PBW_NONE) {
            pbwm2__examine_angle(r, (pbw_index)(i - 1));
            (void)pbwm2__is_sharp(r, r->job->t + i - 1, &shortest2);
            least2 = pbwm2__least(least2, shortest2);
            (void)pbwm2__step(r->job, pbwm2__refined(r));
        }
    }
    r->shortest2 = least2 / 4;
}

/* Gives each vertex a host, each edge of a segment the number of a host. */
static int pbwm2__find_hosts(pbwm2__refiner *r)
{
    pbwm2__job *job = r->job;
    const size_t n = job->points.count;
    size_t i;
    unsigned k;
    job->hosts.count = 0;
    if (!PBWM2__RESERVE(job, job->vertex_host, n)) {
        return 0;
    }
    job->vertex_host.count = n;
    for (i = 0; i < n; i++) {
        job->vertex_host.at[i] = PBWM2__INPUT;
    }
    for (i = 0; i < job->triangles.count; i++) {
        for (k = 0; job->t[i].v[0] != PBW_NONE && k < 3; k++) {
            pbwm2__triangle *t = job->t + i;
            const pbw_index code = (pbw_index)(4 * i + k);
            if (t->edge[k] != PBW_NONE && code < t->link[k]) {
                pbwm2__host host;
                host.a = t->v[pbwm2__next[k]];
                host.b = t->v[pbwm2__last[k]];
                host.edge = t->edge[k];
                host.stuck = host.acute = 0;
                if (!PBWM2__PUSH(job, job->hosts, host)) {
                    return 0;
                }
                pbwm2__mark_edge(job, code, (pbw_index)job->hosts.count - 1);
            }
        }
    }
    return 1;
}

/* Marks the hosts that meet at less than 60 degrees, rounding included, with nothing between them. */
static void pbwm2__find_acute(pbwm2__refiner *r)
{
    pbwm2__job *job = r->job;
    pbwm2__host *hosts = job->hosts.at;
    size_t i;
    for (i = 0; i < 4 * job->triangles.count; i++) {
        const pbwm2__triangle *t = job->t + i / 4;
        const unsigned k = (unsigned)(i % 4);
        if (k < 3 && t->v[0] != PBW_NONE && t->edge[k] != PBW_NONE) {
            const double *z = pbwm2__point(r, t->v[pbwm2__next[k]]), *a = pbwm2__point(r, t->v[pbwm2__last[k]]), *b;
            pbw_index corner = (pbw_index)(i - k + pbwm2__next[k]), edge;
            double dot;
            while (edge = job->t[PBWM2__SLOT(corner)].edge[pbwm2__next[PBWM2__SIDE(corner)]], edge == PBW_NONE) {
                corner = pbwm2__round(job, corner, 0);
            }
            b = pbwm2__point(r, job->t[PBWM2__SLOT(corner)].v[pbwm2__last[PBWM2__SIDE(corner)]]);
            dot = (a[0] - z[0]) * (b[0] - z[0]) + (a[1] - z[1]) * (b[1] - z[1]);
            if (edge != t->edge[k] && dot > 0 && dot * dot > 0.24 * pbwm2__distance2(a, z) * pbwm2__distance2(b, z)
                && (a[0] - z[0]) * (b[1] - z[1]) > (a[1] - z[1]) * (b[0] - z[0])) {
                hosts[t->edge[k]].acute = hosts[edge].acute = 1;
            }
        }
    }
}

/* Sets the sizes of vertices: the caller's, and at the others what they may grow to.  At a vertex where the domain
   touches itself there are two stars, and pbwm2__spread sees one: hence the rounds. */
static int pbwm2__find_sizes(pbwm2__refiner *r)
{
    pbwm2__job *job = r->job;
    const double *given = job->input->sizes;
    const size_t n = job->points.count;
    double *sizes;
    size_t i;
    unsigned k;
    int more = 1;
    if (!PBWM2__RESERVE(job, job->sizes, n)) {
        return 0;
    }
    r->has_sizes = 1;
    r->growth = job->options->gradation > 0 ? job->options->gradation : 0.3;
    sizes = job->sizes.at;
    job->sizes.count = n;
    for (i = 0; i < n; i++) {
        const pbw_index from = job->original.at[i];
        const double size = given != NULL && from < job->input->point_count ? given[from] : 0;
        sizes[i] = fmin(size > 0 ? size : 1e60, pbwm2__size_at(r, (pbw_index)i));
    }
    while (more && !pbwm2__failed(r)) {
        more = 0;
        for (i = 0; i < job->triangles.count; i++) {
            const pbwm2__triangle *t = job->t + i;
            for (k = 0; t->v[0] != PBW_NONE && k < 6; k++) {
                const pbw_index u = t->v[k % 3], v = t->v[(k + 1 + k / 3) % 3];
                const double apart = sqrt(pbwm2__distance2(pbwm2__point(r, u), pbwm2__point(r, v)));
                pbwm2__lower(r, v, fmin(sizes[u] + r->growth * apart, pbwm2__size_of_region(r, t)));
            }
        }
        more = r->lowered.count > 0;
        pbwm2__spread(r);
    }
    return !pbwm2__failed(r);
}

/* Sets bounds from options and the box of the points.  Returns 0 if the coordinates are too large or too small. */
static int pbwm2__set_bounds(pbwm2__refiner *r)
{
    const pbwm2__job *job = r->job;
    const double angle = job->options->angle > 0 || job->options->angle < 0 ? job->options->angle : 30;
    const double radians = (angle > 0 ? angle : 30) * 3.14159265358979323846 / 180, cosine = cos(radians);
    const int conforming = (job->options->flags & PBW_PLANE_CONFORMING) != 0;
    double low[2] = { HUGE_VAL, HUGE_VAL }, high[2] = { -HUGE_VAL, -HUGE_VAL }, most = 0, size2, ulp;
    size_t i;
    for (i = 0; i < 2 * job->points.count; i++) {
        low[i % 2] = fmin(low[i % 2], job->p[i]);
        high[i % 2] = fmax(high[i % 2], job->p[i]);
        most = fmax(most, fabs(job->p[i]));
    }
    size2 = (high[0] - low[0]) * (high[0] - low[0]) + (high[1] - low[1]) * (high[1] - low[1]);
    ulp = most * 1.1102230246251565e-16;
    r->least2 = fmax(1e-20 * size2, 64 * ulp * ulp);
    r->cosine2 = angle > 0 ? cosine * cosine : 2;    /* no cosine is that large */
    r->lens2 = conforming ? 0 : cos(2 * radians) * cos(2 * radians);
    r->off = 0.475 * sqrt((1 + cosine) / (1 - cosine));
    r->sine = sin(radians + 1.7e-5);
    r->cos = cos(radians + 1.7e-5);
    r->cotan = r->cos / r->sine;
    (void)frexp(size2, &r->classes);
    return most <= 1e60 && size2 >= 1e-120;
}

/* Counts the triangles.  Returns about how many sizes ask for: refinement of a square makes 1.56 A / a triangles of
   area a at most in an area A, and 5.1 A / h^2 with edges of length h at most.  Of a function the largest of four
   values in a triangle counts, as it may be small in a small part alone. */
static double pbwm2__estimate(pbwm2__refiner *r)
{
    const pbwm2__job *job = r->job;
    double sum = 0;
    size_t i;
    unsigned k;
    for (i = 0; i < job->triangles.count; i++) {
        const pbwm2__triangle *t = job->t + i;
        if (t->v[0] != PBW_NONE) {
            const double twice = pbwm2__twice_area(r, t), area = pbwm2__area_for(r, t);
            double size = pbwm2__size_for(r, t, 3), many = 1;
            for (k = 0; k < 3 && size > 0 && job->options->size_at != NULL; k++) {
                const double there = pbwm2__size_for(r, t, k);
                size = there > 0 ? pbwm2__most(size, there) : 0;
            }
            if (area > 0) {
                many = pbwm2__most(many, 0.78 * twice / pbwm2__most(area, r->least2));
            }
            if (size > 0) {
                many = pbwm2__most(many, 2.55 * twice / pbwm2__most(size * size, 16 * r->least2));
            }
            sum += many;
            r->triangle_count++;
        }
    }
    return job->options->steiner_limit == 0 ? sum
         : pbwm2__least(sum, (double)r->triangle_count + 2.0 * (double)job->options->steiner_limit);
}

/* Refuses more triangles than wanted. */
static pbw_status pbwm2__allow(pbwm2__job *job, double count)
{
    const double most = job->options->most > 0 ? job->options->most : 5e7;
    if (!(count > most)) {
        return PBW_OK;
    }
    job->plane->report.estimate = count;
    snprintf(job->plane->what, sizeof job->plane->what, "about %.3g triangles, more than most = %.9g allows: "
             "larger sizes or a smaller angle need fewer", count, most);
    return PBW_ERROR_TOO_LARGE;
}

static pbw_status pbwm2__refine_all(pbwm2__refiner *r)
{
    pbwm2__job *job = r->job;
    const size_t limit = job->options->steiner_limit;
    size_t i;
    pbwm2__find_acute(r);
    r->sizing = 1;
    for (i = job->triangles.count; i > 0 && !pbwm2__failed(r); i--) {     /* stacks: the first come out first */
        if (job->t[i - 1].v[0] != PBW_NONE) {
            pbwm2__examine(r, (pbw_index)(i - 1));
            (void)pbwm2__step(job, 0);
        }
    }
    while (!pbwm2__failed(r)) {
        if (limit != 0 && (r->inserted >= limit + job->plane->report.removed || r->inserted / 8 >= limit)) {
            if (r->sizing) {
                pbwm2__begin_angles(r);
            }
            job->plane->report.limited = r->splits.count + r->large.count > 0 || r->filled != 0;
            break;
        }
        if (r->splits.count > 0) {
            r->splits.count -= 2;
            pbwm2__split_edge(r, r->splits.at[r->splits.count],
                              r->splits.at[r->splits.count + 1], NULL);
        } else if (r->large.count > 0) {
            pbwm2__mend_large(r);
        } else if (r->sizing) {
            pbwm2__begin_angles(r);
        } else if (r->filled != 0) {
            pbwm2__mend_sharp(r);
        } else {
            break;
        }
        if (pbwm2__step(job, pbwm2__refined(r))) {
            return pbwm2__say(job, PBW_CANCELLED, NULL);
        }
        if (pbwm2__allow(job, (double)r->triangle_count) != PBW_OK) {
            return PBW_ERROR_TOO_LARGE;
        }
    }
    return job->fault == PBW_OK ? PBW_OK : pbwm2__say(job, job->fault, NULL);
}

/* Counts the triangles that are not as wanted. */
static void pbwm2__count_faults(const pbwm2__refiner *r)
{
    pbw_plane_report *report = &r->job->plane->report;
    const size_t count = r->job->triangles.count;
    double shortest2;
    size_t i;
    r->job->stage = PBW_STAGE_CHECK;
    for (i = 0; i < count && !pbwm2__step(r->job, pbwm2__fraction(i, count)); i++) {
        const pbwm2__triangle *t = r->job->t + i;
        if (t->v[0] != PBW_NONE) {
            report->small_angles += (size_t)pbwm2__is_sharp(r, t, &shortest2);
            report->too_large += (size_t)pbwm2__is_large(r, t);
        }
    }
}

static pbw_status pbwm2__refine(pbwm2__job *job)
{
    pbwm2__refiner r;
    pbw_status status;
    int i, graded;
    memset(&r, 0, sizeof r);
    r.job = job;
    if (!pbwm2__set_bounds(&r)) {
        return pbwm2__say(job, PBW_ERROR_ARGUMENT,
                          "coordinates are too large, or too small, for refinement: scale them");
    }
    graded = job->input->sizes != NULL
          || (job->options->gradation > 0 && (job->options->size_at != NULL || job->input->region_count > 0));
    status = pbwm2__find_hosts(&r) && (!graded || pbwm2__find_sizes(&r)) ? PBW_OK
           : pbwm2__say(job, PBW_ERROR_MEMORY, NULL);
    if (status == PBW_OK) {
        job->plane->report.estimate = pbwm2__estimate(&r);
        status = pbwm2__allow(job, job->plane->report.estimate);
    }
    status = status == PBW_OK ? pbwm2__refine_all(&r) : status;
    if (status == PBW_OK) {
        pbwm2__count_faults(&r);
        status = job->fault == PBW_OK ? PBW_OK : pbwm2__say(job, job->fault, NULL);
    }
    for (i = 0; i < PBWM2__CLASSES; i++) {
        PBW_RELEASE(&job->memory, r.class_of[i]);
    }
    PBW_RELEASE(&job->memory, r.large);
    PBW_RELEASE(&job->memory, r.splits);
    PBW_RELEASE(&job->memory, r.slots);
    PBW_RELEASE(&job->memory, r.boundary);
    PBW_RELEASE(&job->memory, r.hits);
    PBW_RELEASE(&job->memory, r.lowered);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>result       The result.
   In: triangles in slots.  Out: the caller's arrays.
   Holds: triangles begin with their corner of least number along the curve, and are sorted by their corners, so the
   arrays are the same whatever the order in which segments went in.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwm2__block {
    pbw_memory memory;
    PBW_ARRAY(pbwm2__vector) points;
    pbwm2__indices triangles, neighbors, constraints, regions, edges, edge_segments, seeds, crossings;
    PBW_ARRAY(size_t) edge_first;
    PBW_ARRAY(int) windings;
} pbwm2__block;

/* The code of the corner that comes first along the curve. */
static pbw_index pbwm2__first_corner(const pbwm2__job *job, pbw_index slot)
{
    const pbw_index *v = job->t[slot].v;
    return 4 * slot + (v[0] < v[1] && v[0] < v[2] ? 0u : v[1] < v[2] ? 1u : 2u);
}

/* The corner after the first, whose code is given. */
static pbw_index pbwm2__second(const pbwm2__job *job, pbw_index code)
{
    return job->t[PBWM2__SLOT(code)].v[pbwm2__next[PBWM2__SIDE(code)]];
}

/* Sorts triangles of one first corner, by its codes, by their second. */
static int pbwm2__sort_fan(pbwm2__job *job, pbw_index *item, size_t count)
{
    pbwm2__cuts keys;
    size_t i, j;
    int ok = 1;
    memset(&keys, 0, sizeof keys);
    for (i = 1; i < count && count <= 32; i++) {
        const pbw_index code = item[i], second = pbwm2__second(job, code);
        for (j = i; j > 0 && pbwm2__second(job, item[j - 1]) > second; j--) {
            item[j] = item[j - 1];
        }
        item[j] = code;
    }
    for (i = 0; i < count && count > 32 && ok; i++) {
        ok = pbwm2__add_cut(job, &keys, pbwm2__second(job, item[i]), item[i], 0);
    }
    pbwm2__sort(&keys);
    for (i = 0; i < keys.count && ok; i++) {
        item[i] = keys.at[i].other;
    }
    PBW_RELEASE(&job->memory, keys);
    return ok;
}

/* Fills item_of with the codes of first corners, in order; and first_of, per slot in use, with the code of the first
   corner, in which the number of the triangle replaces the slot. */
static int pbwm2__sort_triangles(pbwm2__job *job)
{
    const size_t n = job->points.count, slots = job->triangles.count;
    pbwm2__indices heads;
    pbw_index *head, *next, *item;
    size_t i, count = 0;
    unsigned k;
    int ok = 1;
    memset(&heads, 0, sizeof heads);
    job->item_of.count = job->first_of.count = 0;
    if (!PBWM2__RESERVE(job, job->item_of, slots) || !PBWM2__RESERVE(job, job->first_of, slots)
        || !PBWM2__RESERVE(job, heads, n)) {
        PBW_RELEASE(&job->memory, heads);
        return 0;
    }
    job->side_count = 0;
    head = heads.at;                                 /* lists of codes of first corners, one for each vertex */
    next = job->first_of.at;
    item = job->item_of.at;
    memset(head, 255, n * sizeof *head);
    for (i = slots; i > 0 && ok; i--) {
        const pbwm2__triangle *t = job->t + i - 1;
        ok = !pbwm2__step(job, 0);
        if (t->v[0] != PBW_NONE) {
            const pbw_index code = pbwm2__first_corner(job, (pbw_index)(i - 1));
            next[i - 1] = head[t->v[PBWM2__SIDE(code)]];
            head[t->v[PBWM2__SIDE(code)]] = code;
            for (k = 0; k < 3; k++) {
                job->side_count += (size_t)(t->edge[k] != PBW_NONE) + (size_t)(t->link[k] == PBW_NONE);
            }
        }
    }
    for (i = 0; i < n && ok; i++) {                  /* a quarter of the stage, as each of its loops */
        const size_t first = count;
        pbw_index code;
        for (code = head[i]; code != PBW_NONE; code = next[PBWM2__SLOT(code)]) {
            item[count++] = code;
        }
        ok = pbwm2__sort_fan(job, item + first, count - first) && !pbwm2__step(job, pbwm2__fraction(i, 4 * n));
    }
    for (i = 0; i < count; i++) {
        next[PBWM2__SLOT(item[i])] = (pbw_index)(4 * i + PBWM2__SIDE(item[i]));
    }
    job->item_of.count = count;
    PBW_RELEASE(&job->memory, heads);
    return ok;
}

/* Points, and for each vertex its number, in job->vertex: the caller's, then those of refinement that are in use. */
static int pbwm2__out_points(pbwm2__job *job, pbwm2__block *block)
{
    const size_t n = job->given.count;
    size_t i, next = n;
    job->vertex.count = 0;
    if (!PBWM2__RESERVE(job, job->vertex, job->points.count)) {
        return 0;
    }
    for (i = 0; i < job->points.count; i++) {
        job->vertex.at[i] = i < n ? job->original.at[i]
                                      : job->incident[i] != PBW_NONE ? (pbw_index)next++ : PBW_NONE;
    }
    if (!PBWM2__FIT(job, block->points, next + 1)) {
        return 0;
    }
    memcpy(block->points.at, job->given.at, n * sizeof(pbwm2__vector));
    for (i = n; i < job->points.count; i++) {
        if (job->incident[i] != PBW_NONE) {
            memcpy(block->points.at[job->vertex.at[i]], job->points.at[i], sizeof(pbwm2__vector));
        }
    }
    job->plane->points = block->points.at[0];
    job->plane->point_count = next;
    job->plane->report.steiner_count = next - n;
    return 1;
}

/* Regions are numbered as triangles come. */
static int pbwm2__out_regions(pbwm2__job *job, pbwm2__block *block)
{
    const pbw_index *item = job->item_of.at;
    const pbwm2__component *component = job->components.at;
    const size_t count = job->item_of.count;
    pbw_index *region, *renumber;
    size_t i, regions = 0;
    job->stack.count = 0;
    if (!PBWM2__FIT(job, block->regions, count + 1) || !PBWM2__FIT(job, block->windings, job->components.count + 1)
        || !PBWM2__FIT(job, block->seeds, job->components.count + 1)
        || !PBWM2__RESERVE(job, job->stack, job->components.count)) {
        return 0;
    }
    region = block->regions.at;
    renumber = job->stack.at;
    memset(renumber, 255, job->components.count * sizeof *renumber);
    for (i = 0; i < count; i++) {
        const pbw_index c = job->t[PBWM2__SLOT(item[i])].region;
        if (renumber[c] == PBW_NONE) {
            block->windings.at[regions] = component[c].winding;
            block->seeds.at[regions] = component[c].seed;
            renumber[c] = (pbw_index)regions++;
        }
        region[i] = renumber[c];
    }
    job->plane->regions = region;
    job->plane->region_count = regions;
    job->plane->region_windings = block->windings.at;
    job->plane->region_seeds = block->seeds.at;
    return 1;
}

/* Fills old with the codes of the edges of segments, each in the earlier of its two triangles. */
static int pbwm2__out_triangles(pbwm2__job *job, pbwm2__block *block)
{
    const pbw_index *item = job->item_of.at, *number = job->first_of.at;
    const pbw_index *vertex = job->vertex.at;
    const size_t count = job->item_of.count;
    pbw_index *corner, *neighbor, *edge;
    size_t i, k, edges = 0;
    job->old.count = 0;
    if (!PBWM2__FIT(job, block->triangles, 3 * count + 1) || !PBWM2__FIT(job, block->neighbors, 3 * count + 1)
        || !PBWM2__RESERVE(job, job->old, job->side_count / 2 + 1)) {
        return 0;
    }
    corner = block->triangles.at;
    neighbor = block->neighbors.at;
    edge = job->old.at;
    for (i = 0; i < count && !pbwm2__step(job, 0.25 + pbwm2__fraction(i, 2 * count)); i++) {
        const pbwm2__triangle *t = job->t + PBWM2__SLOT(item[i]);
        unsigned side = PBWM2__SIDE(item[i]);
        if (i + 16 < count) {
            const pbwm2__triangle *soon = job->t + PBWM2__SLOT(item[i + 8]);
            PBW_PREFETCH(job->t + PBWM2__SLOT(item[i + 16]));
            for (k = 0; k < 3; k++) {
                if (soon->link[k] != PBW_NONE) {
                    PBW_PREFETCH(number + PBWM2__SLOT(soon->link[k]));
                }
            }
        }
        for (k = 0; k < 3; k++, side = pbwm2__next[side]) {
            const pbw_index link = t->link[side];
            const pbw_index beyond = link == PBW_NONE ? PBW_NONE : PBWM2__SLOT(number[PBWM2__SLOT(link)]);
            corner[3 * i + k] = vertex[t->v[side]];
            neighbor[3 * i + k] = beyond;
            edge[edges] = 4 * PBWM2__SLOT(item[i]) + side;       /* stays if it counts */
            edges += (size_t)((t->edge[side] != PBW_NONE) & (beyond > i));
        }
    }
    job->old.count = edges;
    job->plane->triangles = corner;
    job->plane->neighbors = neighbor;
    job->plane->triangle_count = count;
    return i == count;
}

static int pbwm2__compare_indices(const void *left, const void *right)
{
    const pbw_index a = *(const pbw_index *)left, b = *(const pbw_index *)right;
    return (a > b) - (a < b);
}

/* Adds the caller's segments on an edge to a list, ascending, each once. */
static int pbwm2__out_segments(pbwm2__job *job, pbwm2__indices *list, pbw_index edge)
{
    const size_t first = list->count;
    size_t count, kept = 0, i;
    pbw_index *item;
    while (edge != PBW_NONE && edge != PBWM2__BORDER) {
        const pbw_index id = pbwm2__id_of(job, pbwm2__take_piece(job, &edge));
        if (id != PBW_NONE && !PBWM2__PUSH(job, *list, id)) {
            return 0;
        }
    }
    count = list->count - first;
    if (count < 2) {
        return 1;
    }
    item = list->at;
    qsort(item + first, count, sizeof *item, pbwm2__compare_indices);
    for (i = 0; i < count; i++) {
        if (i == 0 || item[first + i] != item[first + i - 1]) {
            item[first + kept++] = item[first + i];
        }
    }
    list->count = first + kept;
    return 1;
}

/* Edges of segments, numbered as triangles have them, and the lists of their segments. */
static int pbwm2__out_edges(pbwm2__job *job, pbwm2__block *block)
{
    const pbw_index *code = job->old.at, *number = job->first_of.at;
    const pbw_index *vertex = job->vertex.at;
    const size_t count = job->old.count;
    pbwm2__indices *list = &block->edge_segments;
    pbw_index *constraint, *end;
    size_t *first, i, k;
    if (!PBWM2__FIT(job, block->constraints, 3 * job->item_of.count + 1)
        || !PBWM2__FIT(job, block->edges, 2 * count + 1)
        || !PBWM2__FIT(job, block->edge_first, count + 1) || !PBWM2__FIT(job, *list, count + 1)) {
        return 0;
    }
    constraint = block->constraints.at;
    end = block->edges.at;
    first = block->edge_first.at;
    memset(constraint, 255, 3 * job->item_of.count * sizeof *constraint);
    for (i = 0; i < count; i++) {
        const pbwm2__triangle *t = job->t + PBWM2__SLOT(code[i]);
        const unsigned side = PBWM2__SIDE(code[i]);
        const pbw_index codes[2] = { code[i], t->link[side] };
        for (k = 0; k < 2 && codes[k] != PBW_NONE; k++) {
            const pbw_index own = number[PBWM2__SLOT(codes[k])];
            const unsigned corner = (PBWM2__SIDE(codes[k]) + 3 - PBWM2__SIDE(own)) % 3;
            constraint[3 * (size_t)PBWM2__SLOT(own) + corner] = (pbw_index)i;
        }
        end[2 * i] = vertex[t->v[pbwm2__next[side]]];
        end[2 * i + 1] = vertex[t->v[pbwm2__last[side]]];
        first[i] = list->count;
        if (!pbwm2__out_segments(job, list, pbwm2__host_of(job, t->edge[side]))
            || pbwm2__step(job, 0.75 + pbwm2__fraction(i, 4 * count))) {
            return 0;
        }
    }
    first[count] = list->count;
    job->plane->constraints = constraint;
    job->plane->edge_count = count;
    job->plane->edges = end;
    job->plane->edge_first = first;
    job->plane->edge_segments = list->at;
    return 1;
}

static void pbwm2__block_free(pbwm2__block *block)
{
    pbw_memory memory = block->memory;
    PBW_RELEASE(&memory, block->points);
    PBW_RELEASE(&memory, block->triangles);
    PBW_RELEASE(&memory, block->neighbors);
    PBW_RELEASE(&memory, block->constraints);
    PBW_RELEASE(&memory, block->regions);
    PBW_RELEASE(&memory, block->edges);
    PBW_RELEASE(&memory, block->edge_segments);
    PBW_RELEASE(&memory, block->seeds);
    PBW_RELEASE(&memory, block->crossings);
    PBW_RELEASE(&memory, block->edge_first);
    PBW_RELEASE(&memory, block->windings);
    (void)pbw_memory_resize(&memory, block, 1, 0, sizeof *block);
}

/* Hands over the result, or after a failure the crossings.  If memory is short, plane has only what and crossings. */
static pbw_status pbwm2__hand_over(pbwm2__job *job, pbw_status status)
{
    pbwm2__block *block;
    int ok = 1;
    if (status == PBW_OK && job->fault != PBW_OK) {
        status = pbwm2__say(job, job->fault, NULL);
    }
    if (status != PBW_OK && status != PBW_DEGENERATE && job->crossings.count == 0) {
        return status;
    }
    block = (pbwm2__block *)pbw_memory_resize(&job->memory, NULL, 0, 1, sizeof *block);
    if (block == NULL) {
        return pbwm2__say(job, PBW_ERROR_MEMORY, NULL);
    }
    memset(block, 0, sizeof *block);
    job->stage = PBW_STAGE_OUTPUT;
    if (status == PBW_OK) {
        ok = pbwm2__sort_triangles(job) && pbwm2__out_points(job, block) && pbwm2__out_triangles(job, block)
          && pbwm2__out_regions(job, block) && pbwm2__out_edges(job, block);
    } else if (status == PBW_DEGENERATE) {
        ok = PBWM2__FIT(job, block->points, job->given.count + 1);
        if (ok) {
            memcpy(block->points.at, job->given.at, job->given.count * sizeof(pbwm2__vector));
            job->plane->points = block->points.at[0];
        }
        job->plane->point_count = job->given.count;
    }
    block->crossings = job->crossings;
    memset(&job->crossings, 0, sizeof job->crossings);
    block->memory = job->memory;
    if (!ok) {
        pbwm2__block_free(block);
        memset(job->plane, 0, sizeof *job->plane);
        return pbwm2__say(job, job->fault != PBW_OK ? job->fault : PBW_ERROR_MEMORY, NULL);
    }
    job->plane->crossings = block->crossings.at;
    job->plane->crossing_count = block->crossings.count / 2;
    job->plane->input_count = job->input->point_count;
    job->plane->memory = block;
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>calls        The calls.
   In: the input and options.  Out: a plane, or a status and a text.
   Holds: after a failure nothing is held but the crossings of a plane that pbw_plane_free frees.
   ------------------------------------------------------------------------------------------------------ */

static pbw_status pbwm2__check_arguments(pbwm2__job *job)
{
    const pbw_plane_input *in = job->input;
    const pbw_plane_options *o = job->options;
    const unsigned all = PBW_PLANE_SPLIT_CROSSINGS | PBW_PLANE_REFINE | PBW_PLANE_KEEP_BOUNDARY
                       | PBW_PLANE_KEEP_SEGMENTS | PBW_PLANE_CONFORMING;
    size_t i;
    if ((in->points == NULL && in->point_count > 0) || (in->segments == NULL && in->segment_count > 0)
        || (in->holes == NULL && in->hole_count > 0) || (in->regions == NULL && in->region_count > 0)) {
        return pbwm2__say(job, PBW_ERROR_ARGUMENT, "an array is NULL");
    }
    if ((unsigned)o->rule > PBW_PLANE_NONZERO || (o->flags & ~all) != 0) {
        return pbwm2__say(job, PBW_ERROR_ARGUMENT, "no such rule or flag");
    }
    if (!(o->angle <= 34) || !(o->area >= 0) || !(o->size >= 0) || !(o->gradation >= 0) || !(o->most >= 0)) {
        return pbwm2__say(job, PBW_ERROR_ARGUMENT,
                          "an angle above 34 degrees, or an area, size, gradation or most below 0");
    }
    if (in->point_count > PBW_NONE - 16 || in->segment_count > PBW_NONE / 4) {
        return pbwm2__say(job, PBW_ERROR_TOO_LARGE, NULL);
    }
    for (i = 0; i < 2 * in->segment_count; i++) {
        if (in->segments[i] >= in->point_count) {
            snprintf(job->plane->what, sizeof job->plane->what, "segment %lu has end %lu of %lu points",
                     (unsigned long)(i / 2), (unsigned long)in->segments[i], (unsigned long)in->point_count);
            return PBW_ERROR_ARGUMENT;
        }
    }
    return PBW_OK;
}

static pbw_status pbwm2__copy_input(pbwm2__job *job)
{
    const pbw_plane_input *in = job->input;
    const size_t n = in->point_count, stride = job->build->stride != 0 ? job->build->stride : 2 * sizeof(double);
    pbwm2__piece *segment;
    size_t i;
    if (!PBWM2__FIT(job, job->given, n + 1) || !PBWM2__FIT(job, job->segments, in->segment_count + 1)) {
        return pbwm2__say(job, PBW_ERROR_MEMORY, NULL);
    }
    for (i = 0; i < n; i++) {
        memcpy(job->given.at[i], (const char *)in->points + i * stride, 2 * sizeof(double));
    }
    segment = job->segments.at;
    for (i = 0; i < in->segment_count; i++) {
        segment[i].a = in->segments[2 * i];
        segment[i].b = in->segments[2 * i + 1];
        segment[i].segment = (pbw_index)i;
    }
    job->given.count = n;
    job->segments.count = in->segment_count;
    return PBW_OK;
}

static void pbwm2__job_free(pbwm2__job *job)
{
    PBW_RELEASE(&job->memory, job->triangles);
    PBW_RELEASE(&job->memory, job->points);
    PBW_RELEASE(&job->memory, job->incidents);
    PBW_RELEASE(&job->memory, job->given);
    PBW_RELEASE(&job->memory, job->segments);
    PBW_RELEASE(&job->memory, job->original);
    PBW_RELEASE(&job->memory, job->vertex);
    PBW_RELEASE(&job->memory, job->pieces);
    PBW_RELEASE(&job->memory, job->groups);
    PBW_RELEASE(&job->memory, job->chain[0]);
    PBW_RELEASE(&job->memory, job->chain[1]);
    PBW_RELEASE(&job->memory, job->stack);
    PBW_RELEASE(&job->memory, job->old);
    PBW_RELEASE(&job->memory, job->fresh);
    PBW_RELEASE(&job->memory, job->crossings);
    PBW_RELEASE(&job->memory, job->hosts);
    PBW_RELEASE(&job->memory, job->vertex_host);
    PBW_RELEASE(&job->memory, job->sizes);
    PBW_RELEASE(&job->memory, job->first_of);
    PBW_RELEASE(&job->memory, job->item_of);
    PBW_RELEASE(&job->memory, job->components);
}

PBWDEF pbw_status pbw_plane_make(const pbw_plane_input *input, const pbw_plane_options *options, pbw_plane *plane)
{
    pbw_plane_options defaults;
    pbw_options build;
    pbwm2__job job;
    pbw_status status;
    if (plane == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(plane, 0, sizeof *plane);
    memset(&job, 0, sizeof job);
    memset(&defaults, 0, sizeof defaults);
    memset(&build, 0, sizeof build);
    job.plane = plane;
    job.input = input;
    job.options = options != NULL ? options : &defaults;
    job.build = job.options->build != NULL ? job.options->build : &build;
    pbw_memory_start(&job.memory, job.build);
    job.stage = PBW_STAGE_WORK;
    if (input == NULL) {
        return pbwm2__say(&job, PBW_ERROR_ARGUMENT, "no input");
    }
    status = pbwm2__check_arguments(&job);
    if (status == PBW_OK) {
        status = pbwm2__copy_input(&job);
    }
    if (status == PBW_OK) {
        status = pbwm2__constrain_all(&job);
    }
    if (status == PBW_OK) {
        status = pbwm2__find_domain(&job);
    }
    if (status == PBW_OK && (job.options->flags & PBW_PLANE_REFINE) != 0) {
        status = pbwm2__refine(&job);
    }
    status = pbwm2__hand_over(&job, status);
    pbwm2__job_free(&job);
    if (plane->memory != NULL) {
        ((pbwm2__block *)plane->memory)->memory = job.memory;
        plane->bytes = job.memory.used;
    }
    return status;
}

PBWDEF pbw_status pbw_plane_rings(const double *points, const size_t *first, size_t ring_count,
                                  const pbw_plane_options *options, pbw_plane *plane)
{
    pbw_plane_options own;
    pbw_plane_input input;
    pbw_options build;
    pbwm2__indices segments;
    pbwm2__job job;                                  /* for its memory */
    pbw_status status;
    size_t i, k;
    memset(&input, 0, sizeof input);
    memset(&own, 0, sizeof own);
    memset(&build, 0, sizeof build);
    memset(&segments, 0, sizeof segments);
    memset(&job, 0, sizeof job);
    own = options != NULL ? *options : own;
    own.rule = own.rule == PBW_PLANE_HULL ? PBW_PLANE_EVEN_ODD : own.rule;
    if (plane == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(plane, 0, sizeof *plane);
    job.plane = plane;
    if (first == NULL && ring_count > 0) {
        return pbwm2__say(&job, PBW_ERROR_ARGUMENT, "an array is NULL");
    }
    build = own.build != NULL ? *own.build : build;
    own.build = &build;
    pbw_memory_start(&job.memory, &build);
    input.points = points;
    input.point_count = ring_count > 0 ? first[ring_count] : 0;
    if (input.point_count > PBW_NONE / 4) {
        return pbwm2__say(&job, PBW_ERROR_TOO_LARGE, NULL);
    }
    if (!PBW_FIT(&job.memory, segments, 2 * input.point_count + 1)) {
        return pbwm2__say(&job, PBW_ERROR_MEMORY, NULL);
    }
    for (i = 0; i < ring_count; i++) {
        for (k = first[i]; k < first[i + 1]; k++) {
            segments.at[2 * k] = (pbw_index)k;
            segments.at[2 * k + 1] = (pbw_index)(k + 1 < first[i + 1] ? k + 1 : first[i]);
        }
    }
    input.segments = segments.at;
    input.segment_count = input.point_count;
    build.memory_limit = pbw_memory_left(&job.memory);
    status = pbw_plane_make(&input, &own, plane);
    PBW_RELEASE(&job.memory, segments);
    return status;
}

PBWDEF void pbw_plane_free(pbw_plane *plane)
{
    if (plane != NULL) {
        if (plane->memory != NULL) {
            pbwm2__block_free((pbwm2__block *)plane->memory);
        }
        memset(plane, 0, sizeof *plane);
    }
}

PBW_CONTRACTION_ON
#endif /* PBW_MESH2_IMPLEMENTATION */
