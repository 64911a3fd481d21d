/* pbw_wrap.h - v0.2.0 - closed surfaces around any triangles, segments and points - MIT-0

   QUICK START
   In one source file, define PBW_WRAP_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file, and the implementations of pbw_surface.h and
   pbw_improve.h in the same source file, before it.

       pbw_wrap_input input = {0};
       pbw_wrap_result wrap = {0};
       input.points = points;        input.point_count = n;
       input.triangles = triangles;  input.triangle_count = m;       // holes, crossings, any orientation
       if (pbw_wrap(&input, NULL, NULL, &wrap, NULL) == PBW_OK) {
           printf("%u facets\n", (unsigned)wrap.facet_count);
       }
       pbw_wrap_free(&wrap);

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>work         the work in progress: cells, gates
     >>oracle       places at the offset, tetrahedra that meet elements
     >>centres      centres of cells, radii of gates
     >>cavity       a point is inserted
     >>carve        gates in rounds: verdicts, and vertices with cavities that are apart, on all threads
     >>manifold     tetrahedra that make each vertex's star one fan
     >>fill         vertices inside
     >>result       the arrays of the caller
     >>shells       which share of a wrap is on both sides of something open
     >>stages       all of it in order
     >>solid        good tetrahedra in a wrap; distances

   FUNCTIONS
     pbw_wrap           wraps elements
     pbw_wrap_distance  how far a wrap and its elements are apart
     pbw_wrap_free      frees a wrap
     pbw_wrap_solid     makes good tetrahedra in a wrap

   HOW
   Portaneri, Rouxel-Labbe, Hemmer, Cohen-Steiner, Alliez 2022, "Alpha wrapping with an offset": a box is
   triangulated and carved from outside.  A gate is a facet between a carved tetrahedron and another one that a ball
   of radius alpha can pass without meeting a vertex.  Take the largest gate:
   1. The segment between the centres of its two tetrahedra comes within the offset of an element: the first such
      place becomes a vertex.
   2. Else the tetrahedron meets an element: the place at the offset from the element nearest to its centre becomes a
      vertex.
   3. Else it is carved.
   Vertices are inserted by exact signs, so that the triangulation is Delaunay.  New vertices are at least the offset
   from all others, so it ends.
   Gates are taken in rounds.  All threads compute verdicts, each from its two tetrahedra alone, and cavities of new
   vertices.  Then one thread settles, in order, which cavities are apart from those before them; all threads fill
   these, and the other vertices wait for the next round.

   PROMISES  (tests/test_wrap.c guards them)
     encloses    no facet meets an element, and all elements are inside: a tetrahedron is carved only where separating
                 axes show, with their rounding errors, that it meets none
     manifold    each edge has two facets, and each vertex one fan of them; facets are turned outward
     any input   holes, crossings, overlaps, flat and repeated elements, any orientation
     same        the same bytes for any number of threads
     bounded     no recursion

   CONFIGURATION MACROS
     PBW_WRAP_IMPLEMENTATION    in one source file: compile the implementation there
*/
#ifndef PBW_WRAP_H
#define PBW_WRAP_H
#ifndef PBW_IMPROVE_H
#include "pbw_improve.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbw_wrap_input {            /* elements, numbered through: triangles, segments, single points */
    const double *points;                  /* 3 coordinates each; points of no element count for nothing */
    size_t point_count;
    const pbw_index *triangles;            /* 3 ids each */
    size_t triangle_count;
    const pbw_index *segments;             /* 2 ids each */
    size_t segment_count;
    const pbw_index *singles;              /* 1 id each */
    size_t single_count;
} pbw_wrap_input;

typedef struct pbw_wrap_options {          /* NULL or all zero = best defaults */
    double alpha;                          /* radius of balls that do not pass: holes and gaps below twice that are
                                              closed; 0 = 1/50 of the diagonal of the elements' box, with alpha_at
                                              the diagonal */
    double offset;                         /* of the vertices from the elements; 0 = alpha / 30, without alpha 1/1500
                                              of the diagonal */
    /* Alpha at a place, where it is below alpha; the offset is the least.  Called on the caller's thread. */
    double (*alpha_at)(void *user, const double point[3]);
    void *alpha_user;
    const double *seeds;                   /* 3 coordinates each: cavities with a seed are carved from inside, too */
    size_t seed_count;
    int fast;                              /* 1: looks for places at the offset only where a centre is within it: half
                                              the time, a few percent to a quarter more facets */
    int closing;                           /* 1: where the wrap is a shell around an open surface, looks for an alpha
                                              that closes it, in about twice the time; not with alpha_at */
    double fill;                           /* length of edges inside, about: vertices there make tetrahedra rounder;
                                              0 = none, but those that the surface needed */
    double most;                           /* tetrahedra; 0 = 50 million */
    double seconds;                        /* of all threads' processor time: later there is no wrap, and none that is
                                              closed is looked for; 0 = no limit */
} pbw_wrap_options;

typedef struct pbw_wrap_result {           /* start from {0}; pbw_wrap_free when done */
    size_t point_count, vertex_count, facet_count, tet_count;
    const double *points;                  /* 3 coordinates each: first vertices of the surface, then others */
    const pbw_index *facets;               /* 3 vertices each, counter-clockwise seen from outside */
    const pbw_index *elements;             /* per facet: the number of the element nearest to its centroid */
    const pbw_index *corners;              /* of the tetrahedra that the surface encloses: 4 points each, positively
                                              oriented */
    const pbw_index *neighbors;            /* as in pbw_mesh: the surface's facets have PBW_NONE */
    void *memory;                          /* private */
} pbw_wrap_result;

enum {                                     /* why there is no wrap, with the status in brackets */
    PBW_WRAP_DONE,                         /* there is */
    PBW_WRAP_EMPTY,                        /* no elements (PBW_DEGENERATE) */
    PBW_WRAP_NO_SIZE,                      /* all points are at one place and no alpha is given (PBW_DEGENERATE) */
    PBW_WRAP_NEAR,                         /* the offset is below 1e-9 of the largest coordinate
                                              (PBW_ERROR_ARGUMENT) */
    PBW_WRAP_LARGE,                        /* more tetrahedra than options.most (PBW_ERROR_TOO_LARGE) */
    PBW_WRAP_LATE                          /* options.seconds were over before (PBW_CANCELLED) */
};

typedef struct pbw_wrap_report {
    int refusal;                           /* PBW_WRAP_... */
    double alpha, offset;                  /* that were used */
    double volume, area;                   /* of the wrap; area: of its surface */
    size_t open_edges;                     /* the triangles' edges that an odd number of them has; points at one place
                                              count as one */
    double both_sides;                     /* share of the surface that is on both sides of a sheet, about: the model
                                              is behind it, and behind that, within 1/8 of alpha and the offset, the
                                              surface again; 0 where there are triangles and no open edges */
    int shell;                             /* 1: that is more than 0.4: a thin shell around what is open */
    double closing;                        /* with options.closing, of a shell: an alpha, found by bisection, that
                                              closes it, so that both_sides is at most 0.15; 0: none up to half the
                                              diagonal does, or the time was over */
    size_t components;                     /* of the surface */
    size_t unused_seeds;                   /* seeds that are nearer to an element than alpha and offset */
    size_t crossings, projections, carved; /* vertices by rules 1 and 2, tetrahedra by rule 3 */
    size_t repairs, dropped;               /* tetrahedra that the manifold needed; gates left because of rounding */
    size_t rounds;
    double seconds[3];                     /* of processor time: tree, carving, the rest */
} pbw_wrap_report;

/* Wraps elements; how, options and report may be NULL.  wrap: overwritten, left empty on failure.  Of options, it
   uses threads, run, resize, memory_limit and progress (PBW_STAGE_WORK).  Returns PBW_ERROR_ARGUMENT for ids out of
   range, arrays that are NULL with a count above 0, numbers below zero or NaN and lengths above 1e100,
   PBW_ERROR_NOT_FINITE, PBW_ERROR_TOO_LARGE for more than 2^32 / 3 elements, a status of report.refusal, or what
   pbw_triangulate and pbw_surface_create fail with. */
PBWDEF pbw_status pbw_wrap(const pbw_wrap_input *input, const pbw_wrap_options *how, const pbw_options *options,
                           pbw_wrap_result *wrap, pbw_wrap_report *report);
/* Measures distance[0], of a surface's corners, edge middles and centroids from the elements, at most, and
   distance[1], of the elements' corners and centroids from the surface, at most.  Fails as pbw_wrap does. */
PBWDEF pbw_status pbw_wrap_distance(const pbw_wrap_input *input, const double *points, size_t point_count,
                                    const pbw_index *facets, size_t facet_count, const pbw_options *options,
                                    double distance[2]);
PBWDEF void pbw_wrap_free(pbw_wrap_result *wrap);        /* fine on {0}, fine twice */

typedef struct pbw_wrap_solid_options {    /* NULL or all zero = best defaults */
    double size;                           /* length of edges, about; 0 = 1/40 of the diagonal of the elements' box,
                                              and at least twice wrap.alpha */
    /* alpha: 0 = half the size, and where that makes a shell, the least that closes the model, if that is below 1.5
       times it or there are no triangles.  offset: 0 = 1/8 of the size, and at most half of alpha: so sheets become
       plates that have room for good tetrahedra.  closing, fill and seconds count for nothing. */
    pbw_wrap_options wrap;
    int stay;                              /* 1: points stay at the offset; 0: if the model is closed triangles, they
                                              are pulled onto it as far as it keeps tetrahedra good */
    double target;                         /* of pbw_improve_options; 0 = 30 degrees */
    double seconds;                        /* of all threads' processor time: later there is no wrap, improvement ends
                                              with what it has, and distances are not measured; 0 = no limit */
    const char **stage;                    /* gets the name of the stage, before its progress is reported: wrap,
                                              improve or measure; NULL = none */
} pbw_wrap_solid_options;

typedef struct pbw_wrap_solid_report {
    pbw_wrap_report wrap;                  /* its refusal, too */
    pbw_improve_report improve;
    double size;                           /* that was used */
    double raised;                         /* the alpha that made a shell, if wrap.alpha is a larger one; else 0 */
    size_t points, facets, tets;           /* of the wrap */
    int closed;                            /* 1: the model is closed triangles */
    int late;                              /* 1: options.seconds were over before improvement ended */
    double before[2], after[2];            /* distances of the wrap and of the mesh, as pbw_wrap_distance has them;
                                              -1: options.seconds were over */
    double seconds[2];                     /* of processor time: improvement, distances */
} pbw_wrap_solid_report;

/* Fills a wrap with good tetrahedra; how, options and report may be NULL.  mesh: overwritten, left empty on failure;
   pbw_tets_free when done.  Fails as pbw_wrap and pbw_improve do. */
PBWDEF pbw_status pbw_wrap_solid(const pbw_wrap_input *input, const pbw_wrap_solid_options *how,
                                 const pbw_options *options, pbw_tets *mesh, pbw_wrap_solid_report *report);

#ifdef __cplusplus
}
#endif
#endif /* PBW_WRAP_H */

#if defined(PBW_WRAP_IMPLEMENTATION) && !defined(PBWWRAP__IMPLEMENTED)
#define PBWWRAP__IMPLEMENTED
#if PBWSF__SEAM != 1
#error "pbw_wrap.h is compiled where pbw_surface.h of its version is: define PBW_SURFACE_IMPLEMENTATION, too"
#elif PBWIM__SEAM != 1
#error "pbw_wrap.h is compiled where pbw_improve.h of its version is: define PBW_IMPROVE_IMPLEMENTATION, too"
#else

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

PBW_CONTRACTION_OFF                        /* fused operations would give other coordinates */

/* ------------------------------------------------------------------------------------------------------
   >>work         The work in progress: cells, gates.
   Holds: the cells are the Delaunay triangulation of x; a cell is inside until it is carved; a free slot has
   corner[0] = PBW_NONE; born tells a cell from earlier ones in its slot.
   ------------------------------------------------------------------------------------------------------ */
enum {
    PBWWR__BOX = 8,                        /* corners of the box */
    PBWWR__ICOSAHEDRON = 12,               /* corners around a seed */
    PBWWR__ROUND = 4096,                   /* gates of a round, at most */
    PBWWR__FEW = 64,                       /* gates for one thread alone */
    PBWWR__GRAIN = 16,                     /* verdicts that a thread takes at a time */
    PBWWR__MOST = 48,                      /* cells of a cavity that is found on all threads */
    PBWWR__STEP = 1024,                    /* items of a pass between two questions whether it is cancelled */
    PBWWR__SAMPLE = 4096                   /* facets that are looked at for what is behind them, about */
};
#define PBWWR__NEAREST 1e-9                /* least offset, by the largest coordinate */
#define PBWWR__HIT 1e-3                    /* rule 1 stops so near above the offset, by the offset */
#define PBWWR__BEHIND 0.125                /* of alpha: behind a sheet, facets are at most so far beyond the offset:
                                              the ball, of radius alpha, stood on their corners */
#define PBWWR__SHELL 0.4                   /* a shell has a larger share of its surface on both sides of a sheet, */
#define PBWWR__CLOSED 0.15                 /* a model that is closed has not */
#define PBWWR__RAISED 1.5                  /* times alpha, at most, to close a model with triangles: details stay */

enum { PBWWR__UNKNOWN, PBWWR__APART, PBWWR__MEETS };

typedef struct pbwwr__cell {
    pbw_index corner[4], next[4];          /* positively oriented; next: as in pbw_mesh */
    double centre[3];
    pbw_index born;
    unsigned char carved, meets;           /* meets: does it meet an element? */
} pbwwr__cell;

typedef struct pbwwr__gate {
    double radius;                         /* of the largest ball that passes; HUGE_VAL at corners of box and seeds */
    pbw_index cell, born;                  /* the one that is not carved */
    unsigned facet;
} pbwwr__gate;

typedef struct pbwwr__verdict {            /* small: the serial part of a round reads all of them */
    pbwwr__gate gate;
    pbw_index from, from_born;             /* the carved cell, PBW_NONE outside of the box */
    unsigned char rule, meets, waits;      /* rule 0: none; waits: for the next round */
    unsigned count, outer;                 /* cells in conflict with the place, 0: more than PBWWR__MOST; their outer
                                              facets, 0: nothing is inserted yet */
    pbw_index point, birth;                /* that is inserted; of its first cell */
    size_t first;                          /* of `born`, where its cells are */
    double place[4];                       /* rules 1 and 2; rule 3: radii of the gates at the cell's facets */
} pbwwr__verdict;

typedef struct pbwwr__cavity {             /* of a verdict */
    pbw_index star[PBWWR__MOST];           /* cells in conflict with the place */
    pbw_index around[2 * PBWWR__MOST + 2]; /* beyond their outer facets, of which n cells have at most 2 n + 2, or at
                                              them if there is nothing beyond */
} pbwwr__cavity;

typedef struct pbwwr__work {
    pbw_memory memory;
    pbw_options options;                   /* the caller's threads and job system, with progress of our own */
    const pbw_options *caller;
    const pbw_wrap_options *how;
    pbw_wrap_report *report;
    double alpha, offset, largest, low[3], high[3];      /* largest: coordinate of the box */
    double done;                           /* of the work */
    double until;                          /* processor time when the work is late; 0 = never */
    int cancelled, late;
    pbw_surface surface;                   /* of the elements, as triangles, in the order of its tree */
    pbwsf__triples elements;               /* its triangles */
    pbwsf__vectors places;                 /* its points: three a triangle */
    pbwsf__indices origin;                 /* of each triangle: its number as an element */
    pbwsf__vectors x;
    size_t artificial;                     /* points of box and seeds: the first ones */
    PBW_ARRAY(pbwwr__cell) cells;          /* count: slots in use, free ones included */
    size_t alive;
    pbw_index births;
    pbwsf__indices spare;                  /* free slots, with room for all */
    pbwsf__indices marks;                  /* per point: as visited */
    pbwsf__indices visited, star;          /* per slot, the last search; cells of a search */
    pbwsf__indices born;                   /* cells of insertions */
    pbw_index visit;                       /* visited: visit, in conflict; more, see the searches */
    PBW_ARRAY(pbwwr__gate) gates;          /* a heap, the largest radius first */
    PBW_ARRAY(pbwwr__verdict) verdicts;
    PBW_ARRAY(pbwwr__cavity) cavities;     /* of the verdicts */
    size_t kept;                           /* of the verdicts: the first ones are of the round before */
    PBW_ARRAY(pbwwr__gate) later;          /* more gates of a round's cells */
} pbwwr__work;

static int pbwwr__progress(void *user, pbw_stage stage, double done)
{
    pbwwr__work *w = (pbwwr__work *)user;
    (void)stage;
    (void)done;
    w->late |= w->until > 0 && (double)clock() > w->until;
    w->cancelled |= w->late;
    if (!w->cancelled && w->caller != NULL && w->caller->progress != NULL) {
        w->cancelled = w->caller->progress(w->caller->progress_user, PBW_STAGE_WORK, w->done) != 0;
    }
    return w->cancelled;
}

/* Asks after each PBWWR__STEP items of a pass. */
static int pbwwr__is_cancelled(pbwwr__work *w, size_t item)
{
    return item % PBWWR__STEP == PBWWR__STEP - 1 && pbwwr__progress(w, PBW_STAGE_WORK, 0);
}

static int pbwwr__larger(const pbwwr__gate *a, const pbwwr__gate *b)
{
    return a->radius > b->radius || (a->radius >= b->radius && a->born < b->born);
}

static int pbwwr__push_gate(pbwwr__work *w, const pbwwr__gate *gate)
{
    pbwwr__gate *heap;
    size_t i;
    if (!PBW_PUSH(&w->memory, w->gates, *gate)) {
        return 0;
    }
    heap = w->gates.at;
    for (i = w->gates.count - 1; i > 0 && pbwwr__larger(gate, heap + (i - 1) / 2); i = (i - 1) / 2) {
        heap[i] = heap[(i - 1) / 2];
    }
    heap[i] = *gate;
    return 1;
}

static pbwwr__gate pbwwr__pop_gate(pbwwr__work *w)
{
    pbwwr__gate *heap = w->gates.at;
    const pbwwr__gate top = heap[0], last = heap[--w->gates.count];
    const size_t count = w->gates.count;
    size_t i, child;
    for (i = 0; 2 * i + 1 < count; i = child) {
        child = 2 * i + 1;
        child += child + 1 < count && pbwwr__larger(heap + child + 1, heap + child);
        if (!pbwwr__larger(heap + child, &last)) {
            break;
        }
        heap[i] = heap[child];
    }
    heap[i] = last;
    return top;
}

/* ------------------------------------------------------------------------------------------------------
   >>oracle       Places at the offset, tetrahedra that meet elements.
   In: the tree of the elements.  Out: places, and whether.
   ------------------------------------------------------------------------------------------------------ */
/* Moves *t up to where a + t d comes within the offset of an element, or returns 0 if that is not before `most`.
   The distance from a convex set is convex along a line, so that Newton's method from before the place never passes
   it. */
static int pbwwr__approach(const double *const c[3], const double *a, const double *d, double offset, double most,
                           double *t)
{
    int i;
    for (i = 0; i < 100; i++) {
        double p[3], q[3], u[3], away, slope;
        int k;
        for (k = 0; k < 3; k++) {
            p[k] = a[k] + *t * d[k];
        }
        pbwsf__nearest_in(c[0], c[1], c[2], p, q);
        pbwsf__minus(p, q, u);
        away = sqrt(pbwsf__dot(u, u));
        if (away <= offset * (1 + PBWWR__HIT)) {
            return 1;
        }
        slope = pbwsf__dot(u, d) / away;
        if (!(slope < 0)) {
            return 0;
        }
        *t += (offset - away) / slope;
        if (!(*t < most)) {
            return 0;
        }
    }
    return 0;
}

/* Finds the first place of the segment from a to b that is within the offset of an element.  Returns 0 if there is
   none, or if a is. */
static int pbwwr__first_place(const pbw_surface *surface, const double *a, const double *b, double offset,
                              double place[3])
{
    const pbwsf__tree *tree = (const pbwsf__tree *)surface->memory;
    const pbw_index *order = tree->order.at;
    struct { size_t node; double from; } stack[PBWSF__DEPTH];
    double d[3], per[3], best = 1;
    int depth = 1, found = 0;
    size_t k;
    pbwsf__minus(b, a, d);
    for (k = 0; k < 3; k++) {
        per[k] = fabs(d[k]) > 1e-100 ? 1 / d[k] : fabs(d[k]) > 0 ? 0 : 1e100;
    }
    stack[0].node = 0;
    stack[0].from = 0;
    while (depth > 0) {
        const size_t i = stack[--depth].node;
        const double from = stack[depth].from;
        if (from > best) {
            continue;
        }
        if (i < tree->first_leaf) {                          /* the nearer child is taken first */
            double at[2];
            size_t turned;
            for (k = 0; k < 2; k++) {
                pbwsf__box wide = tree->boxes.at[2 * i + 1 + k];
                int j;
                for (j = 0; j < 3; j++) {
                    wide.low[j] -= offset * (1 + 2 * PBWWR__HIT);
                    wide.high[j] += offset * (1 + 2 * PBWWR__HIT);
                }
                at[k] = pbwsf__box_meets(&wide, a, per, best);
            }
            turned = at[0] > at[1];
            for (k = 2; k-- > 0;) {
                const size_t child = k ^ turned;
                if (at[child] <= best) {
                    stack[depth].node = 2 * i + 1 + child;
                    stack[depth++].from = at[child];
                }
            }
            continue;
        }
        for (k = pbwsf__first_of(tree, i); k < pbwsf__end_of(surface, tree, i); k++) {
            const double *const c[3] = { pbwsf__corner(surface, order[k], 0), pbwsf__corner(surface, order[k], 1),
                                         pbwsf__corner(surface, order[k], 2) };
            double t = from;
            if (pbwwr__approach(c, a, d, offset, best, &t)) {
                if (!(t > 0)) {
                    return 0;
                }
                best = t;
                found = 1;
            }
        }
    }
    pbwsf__between(a, b, best, place);
    return found;
}

typedef struct pbwwr__tet {                /* as a set that may meet others */
    const double *c[4];
    double low[3], high[3];
    double normal[4][3], most[4];          /* of facets, outward; what n . x is above beyond them, see pbwwr__slack */
    int nearest[4][3];                     /* the corner of a box with the least n . x: of the 6 numbers low, high */
    double largest;
    int last;                              /* the facet that had something beyond it before: it is tried first */
} pbwwr__tet;

/* How far two sets' values of n . x must be apart.  A computed n . x differs from the true one of that n and x by up
   to 3.01 u |n|_1 m, where u = 2^-53 and m bounds all coordinates (Higham 2002, "Accuracy and Stability of Numerical
   Algorithms", 3.1, for three products and two sums).  Two of them, and the sum with this number, which is rounded
   twice: below 8 u |n|_1 m = 8.9e-16 |n|_1 m. */
static double pbwwr__slack(const double n[3], double largest)
{
    return 8.9e-16 * (fabs(n[0]) + fabs(n[1]) + fabs(n[2])) * largest;
}

static void pbwwr__set_tet(pbwwr__tet *t, double largest)
{
    int i, k;
    t->largest = largest;
    for (k = 0; k < 3; k++) {
        t->low[k] = t->high[k] = t->c[0][k];
        for (i = 1; i < 4; i++) {
            t->low[k] = t->c[i][k] < t->low[k] ? t->c[i][k] : t->low[k];
            t->high[k] = t->c[i][k] > t->high[k] ? t->c[i][k] : t->high[k];
        }
    }
    for (i = 0; i < 4; i++) {
        double *n = t->normal[i];
        pbwsf__normal(t->c[PBW_FACET_CORNER(i, 0)], t->c[PBW_FACET_CORNER(i, 1)], t->c[PBW_FACET_CORNER(i, 2)], n);
        t->most[i] = -HUGE_VAL;
        for (k = 0; k < 4; k++) {
            const double x = pbwsf__dot(n, t->c[k]);
            t->most[i] = x > t->most[i] ? x : t->most[i];
        }
        t->most[i] += pbwwr__slack(n, largest);
        for (k = 0; k < 3; k++) {
            t->nearest[i][k] = n[k] > 0 ? k : 3 + k;
        }
    }
    t->last = 0;
}

/* Whether an axis shows that the tetrahedron and the triangle are apart. */
static int pbwwr__is_axis(const pbwwr__tet *t, const double *const c[3], const double n[3])
{
    double low[2] = { HUGE_VAL, HUGE_VAL }, high[2] = { -HUGE_VAL, -HUGE_VAL };
    const double slack = pbwwr__slack(n, t->largest);
    int i;
    for (i = 0; i < 7; i++) {
        const int set = i >= 4;
        const double x = pbwsf__dot(n, set ? c[i - 4] : t->c[i]);
        low[set] = x < low[set] ? x : low[set];
        high[set] = x > high[set] ? x : high[set];
    }
    return low[0] > high[1] + slack || low[1] > high[0] + slack;
}

/* Returns 0 only if the tetrahedron and the triangle have no common point. */
static int pbwwr__may_meet(pbwwr__tet *t, const double *const c[3])
{
    double u[3], v[3], n[3];
    int i, j;
    for (i = 0; i < 4; i++) {
        const int f = t->last ^ i;
        if (pbwsf__dot(t->normal[f], c[0]) > t->most[f] && pbwsf__dot(t->normal[f], c[1]) > t->most[f]
            && pbwsf__dot(t->normal[f], c[2]) > t->most[f]) {
            t->last = f;
            return 0;
        }
    }
    pbwsf__normal(c[0], c[1], c[2], n);
    if (pbwwr__is_axis(t, c, n)) {
        return 0;
    }
    for (i = 0; i < 6; i++) {
        const int p = i < 3 ? 0 : i < 5 ? 1 : 2, q = i < 3 ? i + 1 : i < 5 ? i - 1 : 3;
        pbwsf__minus(t->c[q], t->c[p], u);
        for (j = 0; j < 3; j++) {
            pbwsf__minus(c[(j + 1) % 3], c[j], v);
            pbwsf__cross(u, v, n);
            if (pbwwr__is_axis(t, c, n)) {
                return 0;
            }
        }
    }
    return 1;
}

/* Returns 0 only if the tetrahedron and the box have no common point. */
static int pbwwr__may_meet_box(pbwwr__tet *t, const pbwsf__box *box)
{
    double side[6];
    int i;
    if (t->low[0] > box->high[0] || t->high[0] < box->low[0] || t->low[1] > box->high[1]
        || t->high[1] < box->low[1] || t->low[2] > box->high[2] || t->high[2] < box->low[2]) {
        return 0;
    }
    memcpy(side, box->low, sizeof box->low);
    memcpy(side + 3, box->high, sizeof box->high);
    for (i = 0; i < 4; i++) {
        const int f = t->last ^ i, *nearby = t->nearest[f];
        const double *n = t->normal[f];
        if (n[0] * side[nearby[0]] + n[1] * side[nearby[1]] + n[2] * side[nearby[2]] > t->most[f]) {
            t->last = f;
            return 0;
        }
    }
    return 1;
}

/* Returns 0 only if the tetrahedron has no common point with an element. */
static int pbwwr__meets(const pbw_surface *surface, const double *const corner[4], double largest)
{
    const pbwsf__tree *tree = (const pbwsf__tree *)surface->memory;
    const pbw_index *order = tree->order.at;
    size_t stack[PBWSF__DEPTH], k;
    pbwwr__tet t;
    int depth = 1;
    memcpy((void *)t.c, (const void *)corner, sizeof t.c);
    pbwwr__set_tet(&t, largest);
    stack[0] = 0;
    while (depth > 0) {
        const size_t i = stack[--depth];
        if (!pbwwr__may_meet_box(&t, tree->boxes.at + i)) {
            continue;
        }
        if (i < tree->first_leaf) {
            stack[depth++] = 2 * i + 2;
            stack[depth++] = 2 * i + 1;
            continue;
        }
        for (k = pbwsf__first_of(tree, i); k < pbwsf__end_of(surface, tree, i); k++) {
            const double *const c[3] = { pbwsf__corner(surface, order[k], 0), pbwsf__corner(surface, order[k], 1),
                                         pbwsf__corner(surface, order[k], 2) };
            if (pbwwr__may_meet(&t, c)) {
                return 1;
            }
        }
    }
    return 0;
}

/* ------------------------------------------------------------------------------------------------------
   >>centres      Centres of cells, radii of gates.
   In: cells.  Out: places and lengths, rounded: they choose vertices, and nothing exact depends on them.
   ------------------------------------------------------------------------------------------------------ */
static void pbwwr__corners(const pbwwr__work *w, const pbwwr__cell *cell, const double *c[4])
{
    int k;
    for (k = 0; k < 4; k++) {
        c[k] = w->x.at[cell->corner[k]];
    }
}

static void pbwwr__set_centre(const pbwwr__work *w, pbwwr__cell *cell)
{
    const double *c[4];
    double u[3], v[3], t[3], uv[3], vt[3], tu[3], volume, uu, vv, tt, longest;
    int k;
    pbwwr__corners(w, cell, c);
    pbwsf__minus(c[1], c[0], u);
    pbwsf__minus(c[2], c[0], v);
    pbwsf__minus(c[3], c[0], t);
    pbwsf__cross(u, v, uv);
    pbwsf__cross(v, t, vt);
    pbwsf__cross(t, u, tu);
    volume = pbwsf__dot(uv, t);
    uu = pbwsf__dot(u, u), vv = pbwsf__dot(v, v), tt = pbwsf__dot(t, t);
    longest = sqrt(uu > vv ? (uu > tt ? uu : tt) : vv > tt ? vv : tt);
    if (volume > 1e-5 * longest * longest * longest) {       /* errors are then below 1e-9 of the longest edge */
        for (k = 0; k < 3; k++) {
            cell->centre[k] = c[0][k] + (uu * vt[k] + vv * tu[k] + tt * uv[k]) / (2 * volume);
        }
        return;
    }
    (void)pbw_centre(3, c, NULL, t);
    for (k = 0; k < 3; k++) {
        cell->centre[k] = c[0][k] + t[k];
    }
}

/* The radius of the largest ball that passes a facet: of the smallest that is centred between the centres of its two
   cells and has its corners on it. */
static double pbwwr__radius(const pbwwr__work *w, pbw_index cell, unsigned facet)
{
    const pbwwr__cell *to = w->cells.at + cell;
    const double *c[3];
    double u[3], v[3], n[3], p[3], q[3], nn, height, depth;
    unsigned k;
    for (k = 0; k < 3; k++) {
        const pbw_index corner = to->corner[PBW_FACET_CORNER(facet, k)];
        if (corner < w->artificial) {
            return HUGE_VAL;
        }
        c[k] = w->x.at[corner];
    }
    pbwsf__minus(c[1], c[0], u);
    pbwsf__minus(c[2], c[0], v);
    pbwsf__cross(u, v, n);
    pbwsf__minus(to->centre, c[0], p);
    pbwsf__minus(w->cells.at[to->next[facet]].centre, c[0], q);
    nn = pbwsf__dot(n, n);
    depth = pbwsf__dot(p, n);
    height = pbwsf__dot(q, n);
    if ((depth > 0 && height > 0) || (depth < 0 && height < 0) || !(nn > 0)) {
        return sqrt(fmin(pbwsf__dot(p, p), pbwsf__dot(q, q)));
    }
    pbwsf__minus(v, u, q);                           /* |u| |v| |v - u| / (2 |u x v|) */
    return sqrt(pbwsf__dot(u, u) * pbwsf__dot(v, v) / nn * pbwsf__dot(q, q)) / 2;
}

/* Adds the gate, if the ball passes the facet: of a cell that is not carved, with a carved one beyond it. */
static int pbwwr__add_gate(pbwwr__work *w, pbw_index cell, unsigned facet, double radius)
{
    const pbwwr__cell *to = w->cells.at + cell;
    pbwwr__gate gate;
    double alpha = w->alpha;
    gate.radius = radius;
    gate.cell = cell;
    gate.born = to->born;
    gate.facet = facet;
    if (gate.radius > w->offset && w->how->alpha_at != NULL && gate.radius < HUGE_VAL) {
        double middle[3];
        int k;
        for (k = 0; k < 3; k++) {
            middle[k] = w->x.at[to->corner[PBW_FACET_CORNER(facet, 0)]][k] / 3
                      + w->x.at[to->corner[PBW_FACET_CORNER(facet, 1)]][k] / 3
                      + w->x.at[to->corner[PBW_FACET_CORNER(facet, 2)]][k] / 3;
        }
        alpha = fmin(alpha, fmax(w->how->alpha_at(w->how->alpha_user, middle), w->offset));
    }
    return !(gate.radius > alpha) || pbwwr__push_gate(w, &gate);
}

/* ------------------------------------------------------------------------------------------------------
   >>cavity       A point is inserted.
   In: a place inside the box, a cell that may be in conflict with it.  Out: cells that are not carved, and gates.
   ------------------------------------------------------------------------------------------------------ */
static int pbwwr__is_at(const double *a, const double *b)
{
    return a[0] <= b[0] && a[0] >= b[0] && a[1] <= b[1] && a[1] >= b[1] && a[2] <= b[2] && a[2] >= b[2];
}

/* Returns 1 if p is in conflict with the cell, -1 if it is one of its corners. */
static int pbwwr__conflict(const pbwwr__work *w, pbw_index cell, const double p[3])
{
    const double *c[4];
    pbwwr__corners(w, w->cells.at + cell, c);
    return pbwwr__is_at(p, c[0]) || pbwwr__is_at(p, c[1]) || pbwwr__is_at(p, c[2]) || pbwwr__is_at(p, c[3]) ? -1
         : pbw_conflict3(c[0], c[1], c[2], c[3], p, NULL);
}

/* Takes slots for cells, which born has: in the order of their births.  Returns 0 if there is no memory. */
static int pbwwr__take_slots(pbwwr__work *w, size_t count)
{
    pbw_memory *m = &w->memory;
    size_t more = count > w->spare.count ? count - w->spare.count : 0, i;
    if (w->cells.count + more >= PBW_NONE || !PBW_RESERVE(m, w->born, count) || !PBW_RESERVE(m, w->cells, more)
        || !PBW_RESERVE(m, w->visited, more) || !PBW_RESERVE(m, w->spare, w->cells.count + more - w->spare.count)) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        const pbw_index slot = w->spare.count > 0 ? w->spare.at[--w->spare.count] : (pbw_index)w->cells.count++;
        w->visited.at[slot] = 0;
        w->born.at[w->born.count++] = slot;
    }
    w->visited.count = w->cells.count;
    w->births += (pbw_index)count;
    w->alive += count;
    return 1;
}

static unsigned pbwwr__index_of(const pbw_index four[4], pbw_index what)
{
    return four[0] == what ? 0 : four[1] == what ? 1 : four[2] == what ? 2 : 3;
}

/* Links the new cell behind facet i of an old one to the new cell across from corner j: turns around the edge that
   facets i and j have in common, through old cells.  At the cavity's border these have new cells as neighbours. */
static void pbwwr__link(pbwwr__work *w, pbw_index old, unsigned i, unsigned j)
{
    const pbw_index inside = w->visit;
    const pbwwr__cell *cell = w->cells.at + old;
    const pbw_index fresh = cell->next[i];
    const unsigned facet = j;
    pbw_index at = old;
    while (w->visited.at[cell->next[j]] == inside) {
        const pbw_index leave = cell->corner[i], next = cell->next[j];
        cell = w->cells.at + next;
        i = pbwwr__index_of(cell->next, at);
        j = pbwwr__index_of(cell->corner, leave);
        at = next;
    }
    w->cells.at[fresh].next[facet] = cell->next[j];
}

/* Fills star with the cells in conflict with p, from one that is, and counts their outer facets.  Returns 0 if there
   is no memory. */
static int pbwwr__find_conflicts(pbwwr__work *w, pbw_index start, const double p[3], size_t *outer)
{
    size_t i, k;
    w->visit += 3;                                   /* visited: visit, in conflict; visit + 1, not */
    w->star.count = 0;
    *outer = 0;
    if (!PBW_PUSH(&w->memory, w->star, start)) {
        return 0;
    }
    w->visited.at[start] = w->visit;
    for (i = 0; i < w->star.count; i++) {
        for (k = 0; k < 4; k++) {
            const pbw_index next = w->cells.at[w->star.at[i]].next[k];
            if (next != PBW_NONE && w->visited.at[next] < w->visit) {
                w->visited.at[next] = w->visit + 1;
                if (pbwwr__conflict(w, next, p) > 0) {
                    w->visited.at[next] = w->visit;
                    if (!PBW_PUSH(&w->memory, w->star, next)) {
                        return 0;
                    }
                }
            }
            *outer += next == PBW_NONE || w->visited.at[next] != w->visit;
        }
    }
    return 1;
}

/* Replaces the cells of a star, which are visited, by those that join their outer facets to point p, in the slots
   from fresh on.  Reads and writes nothing but the star and the cells around it. */
static void pbwwr__fill_cavity(pbwwr__work *w, const pbw_index *star, size_t count, const pbw_index *fresh,
                               pbw_index birth, pbw_index p)
{
    size_t i;
    unsigned k, j;
    for (i = 0; i < count; i++) {
        const pbw_index old = star[i];
        for (k = 0; k < 4; k++) {
            const pbw_index next = w->cells.at[old].next[k];
            pbwwr__cell *cell;
            if (next != PBW_NONE && w->visited.at[next] == w->visit) {
                continue;
            }
            cell = w->cells.at + *fresh;
            memset(cell, 0, sizeof *cell);
            cell->born = birth++;
            memcpy(cell->corner, w->cells.at[old].corner, sizeof cell->corner);
            cell->corner[k] = p;
            cell->next[k] = next;
            pbwwr__set_centre(w, cell);
            if (next != PBW_NONE) {
                w->cells.at[next].next[pbwwr__index_of(w->cells.at[next].next, old)] = *fresh;
            }
            w->cells.at[old].next[k] = *fresh++;
        }
    }
    for (i = 0; i < count; i++) {
        const pbw_index old = star[i];
        for (k = 0; k < 4; k++) {
            for (j = 0; j < 4 && w->visited.at[w->cells.at[old].next[k]] != w->visit; j++) {
                if (j != k) {
                    pbwwr__link(w, old, k, j);
                }
            }
        }
    }
}

static void pbwwr__free_cells(pbwwr__work *w, const pbw_index *star, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++) {
        w->cells.at[star[i]].corner[0] = PBW_NONE;
        w->spare.at[w->spare.count++] = star[i];
    }
    w->alive -= count;
}

static int pbwwr__add_point(pbwwr__work *w, const double place[3])
{
    if (!PBW_RESERVE(&w->memory, w->x, 1) || !PBW_PUSH(&w->memory, w->marks, 0)) {
        return 0;
    }
    memcpy(w->x.at[w->x.count++], place, sizeof *w->x.at);
    return 1;
}

/* Inserts a place into the star that was found, with so many outer facets; born has the new cells. */
static int pbwwr__fill_star(pbwwr__work *w, const double place[3], size_t outer)
{
    const pbw_index birth = w->births + 1;
    if (!pbwwr__add_point(w, place) || !pbwwr__take_slots(w, outer)) {
        return 0;
    }
    pbwwr__fill_cavity(w, w->star.at, w->star.count, w->born.at, birth, (pbw_index)(w->x.count - 1));
    pbwwr__free_cells(w, w->star.at, w->star.count);
    return 1;
}

/* Adds the gates at new cells around a point. */
static int pbwwr__add_gates(pbwwr__work *w, const pbw_index *born, size_t count, pbw_index point)
{
    size_t i;
    for (i = 0; i < count; i++) {
        const pbwwr__cell *cell = w->cells.at + born[i];
        const unsigned facet = pbwwr__index_of(cell->corner, point);
        const pbw_index next = cell->next[facet];
        if ((next == PBW_NONE || w->cells.at[next].carved)
            && !pbwwr__add_gate(w, born[i], facet, pbwwr__radius(w, born[i], facet))) {
            return 0;
        }
    }
    return 1;
}

/* Returns a cell near a and b that is in conflict with a place; PBW_NONE if there is none.  b may be PBW_NONE. */
static pbw_index pbwwr__find_start(const pbwwr__work *w, const double place[3], pbw_index a, pbw_index b)
{
    const pbw_index nearby[2] = { a, b };
    size_t i;
    for (i = 0; i < 10; i++) {                       /* both, and then their neighbors */
        const pbw_index of = nearby[i < 2 ? i : (i - 2) / 4];
        const pbw_index at = of == PBW_NONE || i < 2 ? of : w->cells.at[of].next[(i - 2) % 4];
        const int conflict = at == PBW_NONE ? 0 : pbwwr__conflict(w, at, place);
        if (conflict != 0) {
            return conflict > 0 ? at : PBW_NONE;
        }
    }
    return PBW_NONE;
}

/* ------------------------------------------------------------------------------------------------------
   >>carve        Gates in rounds: verdicts, and vertices with cavities that are apart, on all threads.
   In: the box and the seeds, triangulated.  Out: cells, carved or not.
   ------------------------------------------------------------------------------------------------------ */
static int pbwwr__is_open(const pbwwr__work *w, const pbwwr__gate *gate)
{
    const pbwwr__cell *cell = w->cells.at + gate->cell;
    const pbw_index next = cell->next[gate->facet];
    return cell->corner[0] != PBW_NONE && cell->born == gate->born && !cell->carved
        && (next == PBW_NONE || w->cells.at[next].carved);
}

/* Finds the element nearest to p.  It is not beyond the limit, but for rounding. */
static pbw_index pbwwr__nearest(const pbwwr__work *w, const double p[3], double limit, double place[3])
{
    const pbw_index found = pbw_surface_closest(&w->surface, p, 1.001 * limit, place);
    return found != PBW_NONE ? found : pbw_surface_closest(&w->surface, p, HUGE_VAL, place);
}

/* The place at the offset from the element nearest to a centre, which is not beyond the radius, on its side. */
static void pbwwr__project(const pbwwr__work *w, const double centre[3], double radius, const double from[3],
                           double place[3])
{
    double nearby[3], d[3], length;
    int k;
    (void)pbwwr__nearest(w, centre, radius, nearby);
    pbwsf__minus(centre, nearby, d);
    length = sqrt(pbwsf__dot(d, d));
    if (!(length > 1e-6 * w->offset)) {
        pbwsf__minus(from, nearby, d);
        length = sqrt(pbwsf__dot(d, d));
    }
    for (k = 0; k < 3; k++) {
        place[k] = nearby[k] + (length > 0 ? d[k] / length * w->offset : 0);
    }
}

static void pbwwr__decide(const pbwwr__work *w, pbwwr__verdict *v)
{
    const pbwwr__cell *to = w->cells.at + v->gate.cell;
    const double *c[4];
    double from[3], nearby[3];
    pbwwr__corners(w, to, c);
    if (v->from != PBW_NONE) {
        memcpy(from, w->cells.at[v->from].centre, sizeof from);
    } else {                                         /* beyond the facet, and beyond all elements */
        double n[3], away = pbwsf__distance(w->low, w->high), length, forward;
        int k;
        pbwsf__normal(c[PBW_FACET_CORNER(v->gate.facet, 0)], c[PBW_FACET_CORNER(v->gate.facet, 1)],
                      c[PBW_FACET_CORNER(v->gate.facet, 2)], n);
        length = sqrt(pbwsf__dot(n, n));
        pbwsf__minus(to->centre, c[PBW_FACET_CORNER(v->gate.facet, 0)], nearby);
        forward = fmax(pbwsf__dot(nearby, n) / length, 0) + away;
        for (k = 0; k < 3; k++) {
            from[k] = to->centre[k] + n[k] / length * forward;
        }
    }
    v->meets = to->meets;
    v->rule = 3;
    if ((!w->how->fast || pbwsf__is_near(&w->surface, to->centre, w->offset))
        && pbwwr__first_place(&w->surface, from, to->centre, w->offset, v->place)) {
        v->rule = 1;
        return;
    }
    if (v->meets == PBWWR__UNKNOWN) {
        v->meets = pbwwr__meets(&w->surface, c, w->largest) ? PBWWR__MEETS : PBWWR__APART;
    }
    if (v->meets == PBWWR__MEETS) {
        v->rule = 2;
        pbwwr__project(w, to->centre, pbwsf__distance(to->centre, c[0]), from, v->place);
    }
}

/* Finds the cells in conflict with a verdict's place, if they are not too many to be searched one by one. */
static void pbwwr__find_cavity(const pbwwr__work *w, pbwwr__verdict *v, pbwwr__cavity *cavity)
{
    const pbw_index start = pbwwr__find_start(w, v->place, v->gate.cell, v->from);
    unsigned i, j, k;
    v->outer = 0;
    v->count = 1;
    cavity->star[0] = start;
    v->rule = start == PBW_NONE ? 0 : v->rule;
    for (i = 0; i < v->count && v->rule != 0; i++) {
        for (k = 0; k < 4; k++) {
            const pbw_index next = w->cells.at[cavity->star[i]].next[k];
            for (j = 0; j < v->count && cavity->star[j] != next; j++) {
            }
            if (j < v->count) {
                continue;
            }
            if (next == PBW_NONE || pbwwr__conflict(w, next, v->place) <= 0) {
                cavity->around[v->outer++] = next == PBW_NONE ? cavity->star[i] : next;
            } else if (v->count < PBWWR__MOST) {
                cavity->star[v->count++] = next;
            } else {
                v->count = 0;
                return;
            }
        }
    }
}

/* Of verdicts that have a place the cavities; of new ones the rules, and the radii of what may become gates. */
static pbw_status pbwwr__decide_some(void *arg, size_t from, size_t to)
{
    const pbwwr__work *w = (const pbwwr__work *)arg;
    for (; from < to; from++) {
        pbwwr__verdict *v = w->verdicts.at + from;
        const pbw_index *next = w->cells.at[v->gate.cell].next;
        unsigned k;
        if (from < w->kept) {
            if (!v->waits) {
                pbwwr__find_cavity(w, v, w->cavities.at + from);
            }
            continue;
        }
        pbwwr__decide(w, v);
        for (k = 0; k < 4 && v->rule == 3; k++) {
            v->place[k] = next[k] == PBW_NONE || w->cells.at[next[k]].carved ? 0
                        : pbwwr__radius(w, next[k], pbwwr__index_of(w->cells.at[next[k]].next, v->gate.cell));
        }
    }
    return PBW_OK;
}

/* Takes the largest gates behind the verdicts that are kept, one of a cell; most of the last ones are of cells that
   are no more.  Returns how many verdicts there are. */
static size_t pbwwr__take_gates(pbwwr__work *w)
{
    size_t most = w->kept + w->gates.count / 8 + 1, count = w->kept, looked = 0, i;
    most = most < PBWWR__ROUND ? most : (size_t)PBWWR__ROUND;
    w->visit += 3;                                   /* visited: visit, it has a verdict */
    for (i = 0; i < count; i++) {
        w->visited.at[w->verdicts.at[i].gate.cell] = w->visit;
    }
    w->later.count = 0;
    while (count < most && w->gates.count > 0 && !pbwwr__is_cancelled(w, looked++)) {
        const pbwwr__gate gate = pbwwr__pop_gate(w);
        pbwwr__verdict *v = w->verdicts.at + count;
        if (!pbwwr__is_open(w, &gate)) {
            continue;
        }
        if (w->visited.at[gate.cell] == w->visit && w->later.count < PBWWR__ROUND) {
            w->later.at[w->later.count++] = gate;
            continue;
        }
        w->visited.at[gate.cell] = w->visit;
        v->gate = gate;
        v->from = w->cells.at[gate.cell].next[gate.facet];
        v->from_born = v->from == PBW_NONE ? 0 : w->cells.at[v->from].born;
        v->waits = 1;
        v->count = 1;
        v->outer = 0;
        count++;
    }
    return count;
}

/* Whether a verdict's star and the cells around it are as they were, apart from those that have been carved. */
static int pbwwr__is_untouched(const pbwwr__work *w, const pbwwr__verdict *v, const pbwwr__cavity *cavity)
{
    size_t i, k;
    for (i = 0; i < v->count && w->visited.at[cavity->star[i]] < w->visit; i++) {
    }
    for (k = 0; k < v->outer && (w->visited.at[cavity->around[k]] < w->visit
                                 || w->visited.at[cavity->around[k]] == w->visit + 2); k++) {
    }
    return i == v->count && k == v->outer;
}

/* Visits a verdict's star and the cells around it, and makes room for the insertion. */
static int pbwwr__claim(pbwwr__work *w, pbwwr__verdict *v, const pbwwr__cavity *cavity)
{
    size_t i;
    v->first = w->born.count;
    v->birth = w->births + 1;
    v->point = (pbw_index)w->x.count;
    if (!pbwwr__add_point(w, v->place) || !pbwwr__take_slots(w, v->outer)) {
        return 0;
    }
    for (i = 0; i < v->outer; i++) {
        w->visited.at[cavity->around[i]] = w->visit + 1;
    }
    for (i = 0; i < v->count; i++) {
        w->visited.at[cavity->star[i]] = w->visit;
    }
    return 1;
}

/* Settles which verdicts of a round are carried out at once: their cavities are apart, so that each is the same
   whatever becomes of the others.  Of those that are kept for the next round, outer is 0; of others, which are void,
   rule is.  visited: visit, a cell that goes; visit + 1, one beside it; visit + 2, one that is carved. */
static pbw_status pbwwr__settle(pbwwr__work *w, size_t count)
{
    size_t i;
    w->visit += 3;
    w->born.count = 0;
    for (i = 0; i < count; i++) {
        pbwwr__verdict *v = w->verdicts.at + i;
        pbwwr__cell *cell = w->cells.at + v->gate.cell;
        if (pbwwr__is_cancelled(w, i)) {
            return PBW_CANCELLED;
        }
        cell->meets = v->meets;
        if (cell->carved || w->visited.at[v->gate.cell] == w->visit
            || (v->from != PBW_NONE && w->visited.at[v->from] == w->visit)) {
            v->rule = 0;                             /* one of the two cells is no more */
        } else if (v->rule == 3) {
            cell->carved = 1;
            w->report->carved++;
            w->visited.at[v->gate.cell] = w->visited.at[v->gate.cell] < w->visit ? w->visit + 2 : w->visit + 1;
        } else if (v->rule == 0) {
            w->report->dropped++;
        } else if (v->count > 0 && !v->waits && pbwwr__is_untouched(w, v, w->cavities.at + i)) {
            w->report->crossings += v->rule == 1;
            w->report->projections += v->rule == 2;
            if (!pbwwr__claim(w, v, w->cavities.at + i)) {
                return PBW_ERROR_MEMORY;
            }
        } else {
            v->outer = 0;
        }
    }
    return PBW_OK;
}

static int pbwwr__inserts(const pbwwr__verdict *v)
{
    return (v->rule == 1 || v->rule == 2) && v->outer > 0;
}

static pbw_status pbwwr__fill_some(void *arg, size_t from, size_t to)
{
    pbwwr__work *w = (pbwwr__work *)arg;
    for (; from < to; from++) {
        const pbwwr__verdict *v = w->verdicts.at + from;
        if (pbwwr__inserts(v)) {
            pbwwr__fill_cavity(w, w->cavities.at[from].star, v->count, w->born.at + v->first, v->birth, v->point);
        }
    }
    return PBW_OK;
}

/* Adds the gates at the facets of a carved cell; new cells have their own. */
static int pbwwr__open_cell(pbwwr__work *w, const pbwwr__verdict *v, pbw_index births)
{
    unsigned k;
    for (k = 0; k < 4; k++) {
        const pbw_index cell = v->gate.cell, next = w->cells.at[cell].next[k];
        if (next != PBW_NONE && !w->cells.at[next].carved && w->cells.at[next].born <= births
            && !pbwwr__add_gate(w, next, pbwwr__index_of(w->cells.at[next].next, cell), v->place[k])) {
            return 0;
        }
    }
    return 1;
}

/* Whether the two cells of a verdict, of which nothing has been carried out, are as they were.  If the other cell is
   new, it has made a gate of its own. */
static int pbwwr__is_valid(const pbwwr__work *w, const pbwwr__verdict *v)
{
    return pbwwr__is_open(w, &v->gate) && w->cells.at[v->gate.cell].next[v->gate.facet] == v->from
        && (v->from == PBW_NONE || w->cells.at[v->from].born == v->from_born);
}

/* Inserts the place of a verdict with a large cavity. */
static pbw_status pbwwr__insert(pbwwr__work *w, const pbwwr__verdict *v)
{
    const pbw_index start = pbwwr__find_start(w, v->place, v->gate.cell, v->from);
    size_t outer;
    w->report->dropped += start == PBW_NONE;
    w->report->crossings += start != PBW_NONE && v->rule == 1;
    w->report->projections += start != PBW_NONE && v->rule == 2;
    w->born.count = 0;
    return start == PBW_NONE
        || (pbwwr__find_conflicts(w, start, v->place, &outer) && pbwwr__fill_star(w, v->place, outer)
            && pbwwr__add_gates(w, w->born.at, outer, (pbw_index)(w->x.count - 1))) ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Carries out the verdicts of a round that have large cavities. */
static pbw_status pbwwr__insert_large(pbwwr__work *w, size_t count)
{
    size_t i, work = 0;
    for (i = 0; i < count; i++) {
        const pbwwr__verdict *v = w->verdicts.at + i;
        if ((v->rule != 1 && v->rule != 2) || v->count > 0 || !pbwwr__is_valid(w, v)) {
            continue;
        }
        if (pbwwr__insert(w, v) != PBW_OK) {
            return PBW_ERROR_MEMORY;
        }
        work += w->star.count;
        if (work >= PBWWR__STEP) {
            work = 0;
            if (pbwwr__progress(w, PBW_STAGE_WORK, 0)) {
                return PBW_CANCELLED;
            }
        }
    }
    return PBW_OK;
}

/* Keeps verdicts with a place that is not inserted yet.  Those of which the cells have no corner in common are tried
   in the next round: others would mostly be in their way. */
static void pbwwr__keep(pbwwr__work *w, size_t count)
{
    size_t i, k;
    w->visit += 3;
    w->kept = 0;
    for (i = 0; i < count; i++) {
        pbwwr__verdict *v = w->verdicts.at + i;
        if ((v->rule == 1 || v->rule == 2) && v->outer == 0 && pbwwr__is_valid(w, v)) {
            const pbw_index *corner = w->cells.at[v->gate.cell].corner;
            v->waits = 0;
            for (k = 0; k < 4; k++) {
                v->waits |= w->marks.at[corner[k]] == w->visit;
            }
            for (k = 0; k < 4 && !v->waits; k++) {
                w->marks.at[corner[k]] = w->visit;
            }
            memmove(w->verdicts.at + w->kept++, v, sizeof *v);
        }
    }
}

static pbw_status pbwwr__carry_out(pbwwr__work *w, size_t count, pbw_options *own)
{
    const pbw_index births = w->births;
    pbw_status status = pbwwr__settle(w, count);
    size_t i;
    own->threads = w->born.count < 32 * PBWWR__FEW ? 1 : w->options.threads;     /* cells are made fast */
    status = status != PBW_OK ? status : pbw_for(own, count, PBWWR__GRAIN, pbwwr__fill_some, w);
    for (i = 0; i < count && status == PBW_OK; i++) {
        const pbwwr__verdict *v = w->verdicts.at + i;
        if (pbwwr__is_cancelled(w, i)) {
            status = PBW_CANCELLED;
        } else if ((v->rule == 3 && !pbwwr__open_cell(w, v, births))
                   || (pbwwr__inserts(v) && !pbwwr__add_gates(w, w->born.at + v->first, v->outer, v->point))) {
            status = PBW_ERROR_MEMORY;
        } else if (pbwwr__inserts(v)) {
            pbwwr__free_cells(w, w->cavities.at[i].star, v->count);
        }
    }
    status = status != PBW_OK ? status : pbwwr__insert_large(w, count);
    pbwwr__keep(w, status == PBW_OK ? count : 0);
    for (i = 0; i < w->later.count && status == PBW_OK; i++) {
        status = !pbwwr__is_open(w, w->later.at + i) || pbwwr__push_gate(w, w->later.at + i) ? PBW_OK
               : PBW_ERROR_MEMORY;
    }
    return status;
}

static pbw_status pbwwr__carve(pbwwr__work *w)
{
    const double most = w->how->most > 0 ? w->how->most : 5e7;
    pbw_options own = w->options;
    pbw_status status = PBW_OK;
    if (!PBW_FIT(&w->memory, w->verdicts, PBWWR__ROUND) || !PBW_FIT(&w->memory, w->cavities, PBWWR__ROUND)
        || !PBW_FIT(&w->memory, w->later, PBWWR__ROUND)) {
        return PBW_ERROR_MEMORY;
    }
    while (status == PBW_OK) {
        const size_t count = pbwwr__take_gates(w);
        if (count == 0) {
            return w->cancelled ? PBW_CANCELLED : PBW_OK;
        }
        w->report->rounds++;
        if (w->verdicts.at[0].gate.radius < HUGE_VAL) {      /* facets are as many as 1 / radius^2 */
            w->done = fmax(w->done, 0.9 * pow(w->alpha / w->verdicts.at[0].gate.radius, 2));
        }
        if (pbwwr__progress(w, PBW_STAGE_WORK, 0)) {
            return PBW_CANCELLED;
        }
        own.threads = count < PBWWR__FEW ? 1 : w->options.threads;           /* to wake some takes longer */
        status = pbw_for(&own, count, PBWWR__GRAIN, pbwwr__decide_some, w);
        status = status != PBW_OK ? status : pbwwr__carry_out(w, count, &own);
        if ((double)w->alive > most) {
            w->report->refusal = PBW_WRAP_LARGE;
            return PBW_ERROR_TOO_LARGE;
        }
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>manifold     Tetrahedra that make each vertex's star one fan.
   In: cells, carved or not.  Out: some that were carved are not, so that around each vertex both the cells that are
   carved and those that are not are linked across facets: their border is then one fan.

   On the sphere around a vertex, a border that is more than one closed curve without a double point leaves more than
   one part of one of the two kinds (Jordan).  Each step takes back a carved cell, so it ends.
   ------------------------------------------------------------------------------------------------------ */
/* Fills star with the cells at a vertex, from one of them; visited is visit there. */
static int pbwwr__find_star(pbwwr__work *w, pbw_index vertex, pbw_index first)
{
    size_t i, k;
    w->visit += 3;
    w->star.count = 0;
    w->visited.at[first] = w->visit;
    if (!PBW_PUSH(&w->memory, w->star, first)) {
        return 0;
    }
    for (i = 0; i < w->star.count; i++) {
        for (k = 0; k < 4; k++) {
            const pbwwr__cell *cell = w->cells.at + w->star.at[i];
            const pbw_index next = cell->next[k];
            if (cell->corner[k] != vertex && next != PBW_NONE && w->visited.at[next] != w->visit) {
                w->visited.at[next] = w->visit;
                if (!PBW_PUSH(&w->memory, w->star, next)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Whether the cell has a facet at the vertex with nothing beyond it. */
static int pbwwr__is_outer(const pbwwr__cell *cell, pbw_index vertex)
{
    int k;
    for (k = 0; k < 4; k++) {
        if (cell->next[k] == PBW_NONE && cell->corner[k] != vertex) {
            return 1;
        }
    }
    return 0;
}

/* Marks a cell of the star that is of one kind, and all that are linked to it. */
static void pbwwr__mark_part(pbwwr__work *w, pbw_index vertex, pbw_index first)
{
    const int carved = w->cells.at[first].carved;
    size_t k;
    w->born.count = 0;                               /* it has room for the star */
    w->visited.at[first] = w->visit + 1;
    w->born.at[w->born.count++] = first;
    while (w->born.count > 0) {
        const pbwwr__cell *cell = w->cells.at + w->born.at[--w->born.count];
        for (k = 0; k < 4; k++) {
            const pbw_index next = cell->next[k];
            if (cell->corner[k] != vertex && next != PBW_NONE && w->visited.at[next] == w->visit
                && w->cells.at[next].carved == carved) {
                w->visited.at[next] = w->visit + 1;
                w->born.at[w->born.count++] = next;
            }
        }
    }
}

/* Whether the star's cells are one part of each kind, or of one kind only; what is outside of the box is carved. */
static int pbwwr__is_fan(pbwwr__work *w, pbw_index vertex)
{
    size_t parts[2] = { 0, 0 }, i;
    int pass;
    for (pass = 0; pass < 2; pass++) {               /* first the part that is linked outside of the box */
        for (i = 0; i < w->star.count; i++) {
            const pbw_index at = w->star.at[i];
            const pbwwr__cell *cell = w->cells.at + at;
            if (pass == 0 && pbwwr__is_outer(cell, vertex)) {
                parts[1] = 1;
            }
            if (w->visited.at[at] == w->visit && (pass == 1 || (cell->carved && pbwwr__is_outer(cell, vertex)))) {
                parts[cell->carved] += (size_t)pass;
                pbwwr__mark_part(w, vertex, at);
            }
        }
    }
    return parts[0] <= 1 && parts[1] <= 1;
}

/* Returns the carved cell of the star with the shortest longest edge; one at corners of box or seeds only if there is
   no other. */
static pbw_index pbwwr__smallest(const pbwwr__work *w)
{
    double best = HUGE_VAL;
    pbw_index found = PBW_NONE;
    size_t i;
    int j, k;
    for (i = 0; i < w->star.count; i++) {
        const pbwwr__cell *cell = w->cells.at + w->star.at[i];
        double longest = 0;
        for (j = 0; j < 4 && cell->carved; j++) {
            for (k = 0; k < j; k++) {
                longest = fmax(longest, pbwsf__distance(w->x.at[cell->corner[j]], w->x.at[cell->corner[k]]));
            }
            longest += cell->corner[j] < w->artificial ? 8 * pbwsf__distance(w->low, w->high) : 0;
        }
        if (cell->carved && longest < best) {
            best = longest;
            found = w->star.at[i];
        }
    }
    return found;
}

static pbw_status pbwwr__make_manifold(pbwwr__work *w)
{
    pbw_memory *m = &w->memory;
    pbwsf__indices first = { NULL, 0, 0 }, queue = { NULL, 0, 0 };       /* per point one of its cells; points */
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, k, looked = 0;
    if (!PBW_ZEROS(m, first, w->x.count) || !PBW_FIT(m, queue, w->x.count)) {
        goto done;
    }
    for (i = 0; i < w->cells.count; i++) {
        if (pbwwr__is_cancelled(w, i)) {
            status = PBW_CANCELLED;
            goto done;
        }
        for (k = 0; k < 4 && w->cells.at[i].corner[0] != PBW_NONE; k++) {
            first.at[w->cells.at[i].corner[k]] = (pbw_index)i;
        }
    }
    for (i = w->x.count; i-- > 0;) {
        queue.at[queue.count++] = (pbw_index)i;
    }
    while (queue.count > 0) {
        const pbw_index vertex = queue.at[--queue.count];
        pbw_index back;
        if (pbwwr__is_cancelled(w, looked++)) {
            status = PBW_CANCELLED;
            goto done;
        }
        if (!pbwwr__find_star(w, vertex, first.at[vertex]) || !PBW_RESERVE(m, w->born, w->star.count)) {
            goto done;
        }
        if (pbwwr__is_fan(w, vertex)) {
            continue;
        }
        back = pbwwr__smallest(w);
        w->cells.at[back].carved = 0;
        w->report->repairs++;
        for (k = 0; k < 4; k++) {
            if (!PBW_PUSH(m, queue, w->cells.at[back].corner[k])) {
                goto done;
            }
        }
    }
    status = PBW_OK;
done:
    PBW_RELEASE(m, first);
    PBW_RELEASE(m, queue);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>fill         Vertices inside.
   In: cells, carved or not.  Out: cells that are not carved, of the size; those that are carved, and with them the
   surface, are as they were: a vertex is inserted only where it is in conflict with none of these.
   ------------------------------------------------------------------------------------------------------ */
#define PBWWR__SLENDER 2.0                 /* cells with a larger radius, by their shortest edge, get a vertex */

/* Whether a cell shall have a vertex in its centre. */
static int pbwwr__is_coarse(const pbwwr__work *w, const pbwwr__cell *cell)
{
    const double *c[4], radius = pbwsf__distance(cell->centre, w->x.at[cell->corner[0]]);
    double shortest = HUGE_VAL;
    int i, k;
    pbwwr__corners(w, cell, c);
    for (i = 1; i < 4; i++) {
        for (k = 0; k < i; k++) {
            shortest = fmin(shortest, pbwsf__distance(c[i], c[k]));
        }
    }
    return radius > 0.8 * w->how->fill || radius > PBWWR__SLENDER * shortest;
}

/* Inserts the centre of a cell, if that leaves all carved cells.  New vertices are farther from all others than the
   shortest edge of the cell, or than 0.8 of the size: so it ends. */
static pbw_status pbwwr__fill_cell(pbwwr__work *w, pbw_index cell)
{
    double place[3];
    size_t i, outer;
    unsigned k;
    memcpy(place, w->cells.at[cell].centre, sizeof place);
    if (pbwwr__conflict(w, cell, place) <= 0) {
        return PBW_OK;
    }
    if (!pbwwr__find_conflicts(w, cell, place, &outer)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < w->star.count; i++) {
        for (k = 0; k < 4; k++) {                    /* not outside of the box, either */
            if (w->cells.at[w->star.at[i]].carved || w->cells.at[w->star.at[i]].next[k] == PBW_NONE) {
                return PBW_OK;
            }
        }
    }
    return pbwwr__fill_star(w, place, outer) ? PBW_OK : PBW_ERROR_MEMORY;
}

static pbw_status pbwwr__fill(pbwwr__work *w)
{
    const double most = w->how->most > 0 ? w->how->most : 5e7;
    PBW_ARRAY(pbwwr__gate) queue = { NULL, 0, 0 };   /* cells, as they were when they came */
    pbw_status status = PBW_OK;
    size_t i, done;
    pbwwr__gate at;
    memset(&at, 0, sizeof at);
    for (i = 0; i < w->cells.count && status == PBW_OK; i++) {
        at.cell = (pbw_index)i;
        at.born = w->cells.at[i].born;
        if (pbwwr__is_cancelled(w, i)) {
            status = PBW_CANCELLED;
        } else if (w->cells.at[i].corner[0] != PBW_NONE && !w->cells.at[i].carved
                   && !PBW_PUSH(&w->memory, queue, at)) {
            status = PBW_ERROR_MEMORY;
        }
    }
    for (done = 0; done < queue.count && status == PBW_OK; done++) {
        const pbwwr__cell *cell;
        at = queue.at[done];
        cell = w->cells.at + at.cell;
        if (pbwwr__is_cancelled(w, done)) {
            status = PBW_CANCELLED;
        } else if (cell->corner[0] == PBW_NONE || cell->born != at.born || !pbwwr__is_coarse(w, cell)) {
            continue;
        } else if ((double)w->alive > most) {
            w->report->refusal = PBW_WRAP_LARGE;
            status = PBW_ERROR_TOO_LARGE;
        } else {
            w->born.count = 0;
            status = pbwwr__fill_cell(w, at.cell);
        }
        for (i = 0; i < w->born.count && status == PBW_OK; i++) {
            at.cell = w->born.at[i];
            at.born = w->cells.at[at.cell].born;
            status = PBW_PUSH(&w->memory, queue, at) ? PBW_OK : PBW_ERROR_MEMORY;
        }
    }
    PBW_RELEASE(&w->memory, queue);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>result       The arrays of the caller.
   In: cells, carved or not.  Out: points along a curve, those of the surface first; tetrahedra by their first points;
   facets in the order of their tetrahedra, with the nearest elements.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwwr__result {
    pbw_memory memory;
    pbwsf__vectors points;
    pbwsf__triples facets;
    pbwsf__indices elements;
    pbwsf__quadruples corners, neighbors;
} pbwwr__result;

PBWDEF void pbw_wrap_free(pbw_wrap_result *wrap)
{
    if (wrap != NULL && wrap->memory != NULL) {
        pbwwr__result *r = (pbwwr__result *)wrap->memory;
        pbw_memory memory = r->memory;
        PBW_RELEASE(&memory, r->points);
        PBW_RELEASE(&memory, r->facets);
        PBW_RELEASE(&memory, r->elements);
        PBW_RELEASE(&memory, r->corners);
        PBW_RELEASE(&memory, r->neighbors);
        (void)pbw_memory_resize(&memory, r, 1, 0, sizeof *r);
    }
    if (wrap != NULL) {
        memset(wrap, 0, sizeof *wrap);
    }
}

static int pbwwr__is_kept(const pbwwr__work *w, size_t cell)
{
    return w->cells.at[cell].corner[0] != PBW_NONE && !w->cells.at[cell].carved;
}

static int pbwwr__is_facet(const pbwwr__work *w, size_t cell, size_t k)
{
    const pbw_index next = w->cells.at[cell].next[k];
    return next == PBW_NONE || w->cells.at[next].carved;
}

/* Numbers points: number[p], first those of facets, then those inside, each along a curve; PBW_NONE: it has no cell
   that is kept. */
static pbw_status pbwwr__number_points(pbwwr__work *w, pbwsf__indices *number, pbwwr__result *r,
                                       pbw_wrap_result *wrap)
{
    pbw_memory *m = &w->memory;
    pbwsf__indices of = { NULL, 0, 0 }, order = { NULL, 0, 0 };          /* points; their places along the curve */
    pbwsf__vectors places = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, k, j, part;
    if (!PBW_ZEROS(m, *number, w->x.count) || !PBW_FIT(m, of, w->x.count) || !PBW_FIT(m, order, w->x.count)
        || !PBW_FIT(m, places, w->x.count)) {
        goto done;
    }
    for (i = 0; i < w->cells.count; i++) {           /* 2: of a facet, 1: inside */
        if (pbwwr__is_cancelled(w, i)) {
            status = PBW_CANCELLED;
            goto done;
        }
        for (k = 0; k < 4 && pbwwr__is_kept(w, i); k++) {
            for (j = 0; j < 4; j++) {
                pbw_index *at = number->at + w->cells.at[i].corner[j];
                *at = j != k && pbwwr__is_facet(w, i, k) ? 2 : *at > 1 ? *at : 1;
            }
        }
    }
    for (i = j = 0; i < w->x.count; i++) {
        j += number->at[i] > 0;
    }
    if (!PBW_FIT(m, r->points, j)) {
        goto done;
    }
    for (part = 2; part > 0; part--) {
        for (i = 0, of.count = 0; i < w->x.count && !pbwwr__is_cancelled(w, i); i++) {
            if (number->at[i] == part) {
                memcpy(places.at[of.count], w->x.at[i], sizeof *places.at);
                of.at[of.count++] = (pbw_index)i;
            }
        }
        status = w->cancelled ? PBW_CANCELLED
               : pbw_order(3, (const double *)places.at, of.count, &w->options, order.at);
        if (status != PBW_OK && status != PBW_DEGENERATE) {
            goto done;
        }
        for (i = 0; i < of.count && !pbwwr__is_cancelled(w, i); i++) {
            memcpy(r->points.at[r->points.count++], places.at[order.at[i]], sizeof *places.at);
            number->at[of.at[order.at[i]]] = (pbw_index)(wrap->point_count + i) + 3;
        }
        wrap->point_count += of.count;
        wrap->vertex_count = part == 2 ? of.count : wrap->vertex_count;
    }
    for (i = 0; i < w->x.count; i++) {
        number->at[i] = number->at[i] == 0 ? PBW_NONE : number->at[i] - 3;
    }
    status = w->cancelled ? PBW_CANCELLED : PBW_OK;
done:
    PBW_RELEASE(m, of);
    PBW_RELEASE(m, order);
    PBW_RELEASE(m, places);
    return status;
}

/* Fills the tetrahedra: those with the least first points first. */
static pbw_status pbwwr__number_tets(pbwwr__work *w, const pbwsf__indices *number, pbwwr__result *r, size_t count)
{
    pbw_memory *m = &w->memory;
    pbwsf__indices cells = { NULL, 0, 0 }, order = { NULL, 0, 0 }, place = { NULL, 0, 0 };
    PBW_ARRAY(uint64_t) keys = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, k;
    if (PBW_FIT(m, cells, count) && PBW_FIT(m, order, count) && PBW_FIT(m, keys, count)
        && PBW_FIT(m, place, w->cells.count) && PBW_FIT(m, r->corners, count) && PBW_FIT(m, r->neighbors, count)) {
        status = PBW_OK;
        for (i = 0; i < w->cells.count && status == PBW_OK; i++) {
            status = pbwwr__is_cancelled(w, i) ? PBW_CANCELLED : PBW_OK;
            if (pbwwr__is_kept(w, i)) {
                uint64_t least = PBW_NONE;
                for (k = 0; k < 4; k++) {
                    const pbw_index p = number->at[w->cells.at[i].corner[k]];
                    least = p < least ? p : least;
                }
                keys.at[cells.count] = least;
                cells.at[cells.count++] = (pbw_index)i;
            }
        }
        status = status != PBW_OK ? status : pbw_sort(keys.at, count, &w->options, order.at);
    }
    for (i = 0; i < count && status == PBW_OK; i++) {
        place.at[cells.at[order.at[i]]] = (pbw_index)i;
        status = pbwwr__is_cancelled(w, i) ? PBW_CANCELLED : PBW_OK;
    }
    for (i = 0; i < count && status == PBW_OK; i++) {
        const size_t at = cells.at[order.at[i]];
        status = pbwwr__is_cancelled(w, i) ? PBW_CANCELLED : PBW_OK;
        for (k = 0; k < 4; k++) {
            r->corners.at[i][k] = number->at[w->cells.at[at].corner[k]];
            r->neighbors.at[i][k] = pbwwr__is_facet(w, at, k) ? PBW_NONE : place.at[w->cells.at[at].next[k]];
        }
    }
    PBW_RELEASE(m, cells);
    PBW_RELEASE(m, order);
    PBW_RELEASE(m, keys);
    PBW_RELEASE(m, place);
    return status;
}

typedef struct pbwwr__near {               /* facets that look for their elements */
    const pbwwr__work *work;
    pbwwr__result *result;
} pbwwr__near;

static pbw_status pbwwr__find_nearest(void *arg, size_t from, size_t to)
{
    const pbwwr__near *nearby = (const pbwwr__near *)arg;
    for (; from < to; from++) {
        const pbw_index *f = nearby->result->facets.at[from];
        double middle[3], place[3];
        int k;
        for (k = 0; k < 3; k++) {
            middle[k] = nearby->result->points.at[f[0]][k] / 3 + nearby->result->points.at[f[1]][k] / 3
                      + nearby->result->points.at[f[2]][k] / 3;
        }
        nearby->result->elements.at[from] = nearby->work->origin.at[pbwwr__nearest(
            nearby->work, middle, pbwsf__distance(middle, nearby->result->points.at[f[0]]) + nearby->work->offset,
            place)];
    }
    return PBW_OK;
}

static pbw_status pbwwr__list_facets(pbwwr__work *w, pbwwr__result *r, size_t tets, size_t facets)
{
    pbwwr__near nearby;
    size_t t, k, j;
    if (!PBW_FIT(&w->memory, r->facets, facets) || !PBW_FIT(&w->memory, r->elements, facets)) {
        return PBW_ERROR_MEMORY;
    }
    for (t = 0; t < tets; t++) {
        if (pbwwr__is_cancelled(w, t)) {
            return PBW_CANCELLED;
        }
        for (k = 0; k < 4; k++) {
            if (r->neighbors.at[t][k] == PBW_NONE) {
                for (j = 0; j < 3; j++) {
                    r->facets.at[r->facets.count][j] = r->corners.at[t][PBW_FACET_CORNER(k, j)];
                }
                r->facets.count++;
            }
        }
    }
    nearby.work = w;
    nearby.result = r;
    return pbw_for(&w->options, facets, 256, pbwwr__find_nearest, &nearby);
}

/* Sums up what is inside: its volume, its surface's area, numbers of tetrahedra and facets. */
static pbw_status pbwwr__measure(pbwwr__work *w, double *volume, double *area, size_t *tets, size_t *facets)
{
    size_t i, k;
    *volume = *area = 0;
    *tets = *facets = 0;
    for (i = 0; i < w->cells.count; i++) {
        const double *c[4];
        double n[3], d[3];
        if (pbwwr__is_cancelled(w, i)) {
            return PBW_CANCELLED;
        }
        if (!pbwwr__is_kept(w, i)) {
            continue;
        }
        pbwwr__corners(w, w->cells.at + i, c);
        pbwsf__normal(c[0], c[1], c[2], n);
        pbwsf__minus(c[3], c[0], d);
        *volume += pbwsf__dot(n, d) / 6;
        ++*tets;
        for (k = 0; k < 4; k++) {
            if (pbwwr__is_facet(w, i, k)) {
                pbwsf__normal(c[PBW_FACET_CORNER(k, 0)], c[PBW_FACET_CORNER(k, 1)], c[PBW_FACET_CORNER(k, 2)], n);
                *area += sqrt(pbwsf__dot(n, n)) / 2;
                ++*facets;
            }
        }
    }
    return PBW_OK;
}

/* Counts the surface's parts that edges join. */
static pbw_status pbwwr__count_components(pbwwr__work *w, const pbwwr__result *r, size_t vertices)
{
    pbwsf__indices tree = { NULL, 0, 0 };            /* the root of a component is its own parent */
    pbw_status status = PBW_OK;
    size_t i, k;
    if (!PBW_FIT(&w->memory, tree, vertices)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < vertices; i++) {
        tree.at[i] = (pbw_index)i;
    }
    w->report->components = vertices;
    for (i = 0; i < r->facets.count && status == PBW_OK; i++) {
        status = pbwwr__is_cancelled(w, i) ? PBW_CANCELLED : PBW_OK;
        for (k = 0; k < 2; k++) {
            pbw_index a = r->facets.at[i][k], b = r->facets.at[i][k + 1];
            while (tree.at[a] != a) {
                a = tree.at[a] = tree.at[tree.at[a]];
            }
            while (tree.at[b] != b) {
                b = tree.at[b] = tree.at[tree.at[b]];
            }
            w->report->components -= a != b;
            tree.at[a < b ? b : a] = a < b ? a : b;
        }
    }
    PBW_RELEASE(&w->memory, tree);
    return status;
}

static pbw_status pbwwr__output(pbwwr__work *w, pbw_wrap_result *wrap)
{
    pbwsf__indices number = { NULL, 0, 0 };
    pbwwr__result *r = (pbwwr__result *)pbw_memory_resize(&w->memory, NULL, 0, 1, sizeof *r);
    pbw_status status;
    if (r == NULL) {
        return PBW_ERROR_MEMORY;
    }
    memset(r, 0, sizeof *r);
    wrap->memory = r;
    status = pbwwr__measure(w, &w->report->volume, &w->report->area, &wrap->tet_count, &wrap->facet_count);
    status = status != PBW_OK ? status : pbwwr__number_points(w, &number, r, wrap);
    status = status != PBW_OK ? status : pbwwr__number_tets(w, &number, r, wrap->tet_count);
    status = status != PBW_OK ? status : pbwwr__list_facets(w, r, wrap->tet_count, wrap->facet_count);
    status = status != PBW_OK ? status : pbwwr__count_components(w, r, wrap->vertex_count);
    PBW_RELEASE(&w->memory, number);
    r->memory = w->memory;
    wrap->points = (const double *)r->points.at;
    wrap->facets = (const pbw_index *)r->facets.at;
    wrap->elements = r->elements.at;
    wrap->corners = (const pbw_index *)r->corners.at;
    wrap->neighbors = (const pbw_index *)r->neighbors.at;
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>shells       Which share of a wrap is on both sides of something open.
   In: elements; cells, carved or not.  Out: the number of open edges, and the share.
   ------------------------------------------------------------------------------------------------------ */
/* Counts the edges of an odd number of triangles.  A corner is known by its coordinates, mixed, and so is an edge. */
static pbw_status pbwwr__count_open(pbwwr__work *w, const pbw_wrap_input *in)
{
    PBW_ARRAY(uint64_t) keys = { NULL, 0, 0 };
    pbwsf__indices order = { NULL, 0, 0 };
    const size_t count = 3 * in->triangle_count;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, k, end, edges = 0;
    if (PBW_FIT(&w->memory, keys, count) && PBW_FIT(&w->memory, order, count)) {
        status = PBW_OK;
        for (i = 0; i < count && status == PBW_OK; i++) {
            const double *ends[2];
            uint64_t key[2] = { 0, 0 };
            status = pbwwr__is_cancelled(w, i) ? PBW_CANCELLED : PBW_OK;
            ends[0] = in->points + 3 * (size_t)in->triangles[i];
            ends[1] = in->points + 3 * (size_t)in->triangles[i % 3 == 2 ? i - 2 : i + 1];
            for (k = 0; k < 6; k++) {
                key[k / 3] = pbw_random(key[k / 3], pbw_sort_key(ends[k / 3][k % 3]));
            }
            keys.at[i] = key[0] == key[1] ? 0 : pbw_random(key[0] < key[1] ? key[0] : key[1],
                                                           key[0] < key[1] ? key[1] : key[0]);
        }
        status = status != PBW_OK ? status : pbw_sort(keys.at, count, &w->options, order.at);
    }
    for (i = 0; i < count && status == PBW_OK; i = end) {
        for (end = i + 1; end < count && keys.at[order.at[end]] == keys.at[order.at[i]]; end++) {
        }
        status = pbwwr__is_cancelled(w, edges++) ? PBW_CANCELLED : PBW_OK;
        w->report->open_edges += keys.at[order.at[i]] != 0 && (end - i) % 2 == 1;
    }
    PBW_RELEASE(&w->memory, keys);
    PBW_RELEASE(&w->memory, order);
    return status;
}

/* Whether a place is beyond the surface.  Walks to it from a cell, which ends, as the cells are Delaunay. */
static int pbwwr__is_outside(const pbwwr__work *w, pbw_index at, const double p[3])
{
    unsigned k = 0;
    while (at != PBW_NONE && k < 4) {
        const double *c[4];
        pbwwr__corners(w, w->cells.at + at, c);
        for (k = 0; k < 4; k++) {
            const double *const corner = c[k];
            c[k] = p;
            if (pbw_orient3(c[0], c[1], c[2], c[3]) < 0) {
                at = w->cells.at[at].next[k];
                break;
            }
            c[k] = corner;
        }
    }
    return at == PBW_NONE || w->cells.at[at].carved;
}

/* Whether the surface is on the other side of the element nearest to a vertex of this cell, too, and no other element
   is between: then the line through both leaves the surface within PBWWR__BEHIND. */
static int pbwwr__is_sheet(const pbwwr__work *w, pbw_index cell, pbw_index vertex)
{
    const double *v = w->x.at[vertex];
    double nearby[3], d[3], place[3], p[3], t, length, alpha = w->alpha;
    int k, sheet = 1;
    if (w->how->alpha_at != NULL) {
        alpha = fmin(alpha, fmax(w->how->alpha_at(w->how->alpha_user, v), w->offset));
    }
    (void)pbwwr__nearest(w, v, w->offset, nearby);
    pbwsf__minus(nearby, v, d);
    length = sqrt(pbwsf__dot(d, d));
    for (t = w->offset + PBWWR__BEHIND * alpha; sheet && t > w->offset / 2; t /= 2) {
        for (k = 0; k < 3; k++) {
            p[k] = nearby[k] + (length > 0 ? d[k] / length * t : 0);
        }
        sheet = (t < w->offset + PBWWR__BEHIND * alpha || pbwwr__is_outside(w, cell, p))
             && pbw_surface_closest(&w->surface, p, t / 2, place) == PBW_NONE;
    }
    return sheet;
}

/* Returns the share of the surface's area that is on both sides of what it is around, from some of its facets;
   nothing of value once the work is cancelled. */
static double pbwwr__both_sides(pbwwr__work *w)
{
    double area = 0, both = 0, n[3];
    size_t i, k, facets = 0, taken = 0, pass;
    for (pass = 0; pass < 2; pass++) {
        for (i = 0; i < w->cells.count && !pbwwr__is_cancelled(w, i); i++) {
            for (k = 0; k < 4 && pbwwr__is_kept(w, i); k++) {
                const pbw_index *const corner = w->cells.at[i].corner;
                if (!pbwwr__is_facet(w, i, k)) {
                    continue;
                }
                facets += pass == 0;
                if (pass == 1 && taken++ % (facets / PBWWR__SAMPLE + 1) == 0) {
                    pbwsf__normal(w->x.at[corner[PBW_FACET_CORNER(k, 0)]], w->x.at[corner[PBW_FACET_CORNER(k, 1)]],
                                  w->x.at[corner[PBW_FACET_CORNER(k, 2)]], n);
                    n[0] = sqrt(pbwsf__dot(n, n));
                    area += n[0];
                    both += pbwwr__is_sheet(w, (pbw_index)i, corner[PBW_FACET_CORNER(k, 0)]) ? n[0] : 0;
                }
            }
        }
    }
    return area > 0 ? both / area : 0;
}

/* ------------------------------------------------------------------------------------------------------
   >>stages       All of it in order.
   In: elements.  Out: the wrap and the report.
   ------------------------------------------------------------------------------------------------------ */
static int pbwwr__are_below(const pbw_index *ids, size_t count, size_t most)
{
    while (count > 0 && ids[count - 1] < most) {
        count--;
    }
    return count == 0;
}

/* Whether three points are on a line. */
static int pbwwr__are_in_line(const double *a, const double *b, const double *c)
{
    int k, flat = 1;
    for (k = 0; k < 3 && flat; k++) {
        const double p[3][2] = { { a[k], a[(k + 1) % 3] }, { b[k], b[(k + 1) % 3] }, { c[k], c[(k + 1) % 3] } };
        flat = pbw_orient2(p[0], p[1], p[2]) == 0;
    }
    return flat;
}

/* Gives a triangle without area the ends of its longest edge, the second one twice. */
static void pbwwr__flatten(pbwsf__vector c[3])
{
    const double ab = pbwsf__distance(c[0], c[1]), bc = pbwsf__distance(c[1], c[2]);
    const double ca = pbwsf__distance(c[2], c[0]);
    if (bc > ab && bc >= ca) {
        memcpy(c[0], c[2], sizeof *c);
    } else if (ca > ab) {
        memcpy(c[1], c[2], sizeof *c);
    }
    memcpy(c[2], c[1], sizeof *c);
}

/* Fills the triangles: a segment has its second corner twice, a single point is a triangle of three. */
static void pbwwr__list_elements(pbwwr__work *w, const pbw_wrap_input *in, size_t total)
{
    size_t i;
    for (i = 0; i < total; i++) {
        const size_t s = i - in->triangle_count, p = s - in->segment_count;
        pbw_index *c = w->elements.at[i];
        if (i < in->triangle_count) {
            memcpy(c, in->triangles + 3 * i, sizeof *w->elements.at);
        } else if (s < in->segment_count) {
            c[0] = in->segments[2 * s];
            c[1] = c[2] = in->segments[2 * s + 1];
        } else {
            c[0] = c[1] = c[2] = in->singles[p];
        }
    }
}

/* Makes the tree, and then its triangles and their corners lie in memory in its order: queries read what is near. */
static pbw_status pbwwr__load(pbwwr__work *w, const pbw_wrap_input *in)
{
    const size_t total = in->triangle_count + in->segment_count + in->single_count;
    pbwsf__tree *tree;
    pbw_status status;
    size_t i;
    if (!pbwwr__are_below(in->triangles, 3 * in->triangle_count, in->point_count)
        || !pbwwr__are_below(in->segments, 2 * in->segment_count, in->point_count)
        || !pbwwr__are_below(in->singles, in->single_count, in->point_count)) {
        return PBW_ERROR_ARGUMENT;
    }
    if (!PBW_FIT(&w->memory, w->elements, total) || !PBW_FIT(&w->memory, w->places, 3 * total)
        || !PBW_FIT(&w->memory, w->origin, total)) {
        return PBW_ERROR_MEMORY;
    }
    pbwwr__list_elements(w, in, total);
    status = pbw_surface_create(in->points, in->point_count, (const pbw_index *)w->elements.at, total, &w->options,
                                &w->surface);
    if (status != PBW_OK) {
        return status;
    }
    tree = (pbwsf__tree *)w->surface.memory;
    for (i = 0; i < 3 * total && !pbwwr__is_cancelled(w, i); i++) {
        memcpy(w->places.at[i], pbwsf__corner(&w->surface, tree->order.at[i / 3], (int)(i % 3)),
               sizeof *w->places.at);
    }
    for (i = 0; i < total; i++) {
        pbwsf__vector *const c = w->places.at + 3 * i;
        if (w->cancelled || pbwwr__is_cancelled(w, i)) {
            return PBW_CANCELLED;
        }
        if (pbwwr__are_in_line(c[0], c[1], c[2])) {
            pbwwr__flatten(c);
        }
        w->origin.at[i] = tree->order.at[i];
        tree->order.at[i] = (pbw_index)i;
        w->elements.at[i][0] = (pbw_index)(3 * i);
        w->elements.at[i][1] = (pbw_index)(3 * i + 1);
        w->elements.at[i][2] = (pbw_index)(3 * i + 2);
    }
    w->surface.points = (const double *)w->places.at;
    w->surface.point_count = 3 * total;
    return PBW_OK;
}

/* Frees what pbwwr__load makes. */
static void pbwwr__unload(pbwwr__work *w)
{
    pbw_surface_free(&w->surface);
    PBW_RELEASE(&w->memory, w->elements);
    PBW_RELEASE(&w->memory, w->places);
    PBW_RELEASE(&w->memory, w->origin);
}

/* Sets alpha, the offset and the box. */
static pbw_status pbwwr__set_lengths(pbwwr__work *w, double alpha)
{
    const pbwsf__box *box = ((const pbwsf__tree *)w->surface.memory)->boxes.at;
    const double diagonal = pbwsf__distance(box->low, box->high), margin = 0.1 * diagonal;
    double largest = 0;
    int k;
    w->alpha = alpha > 0 ? alpha : w->how->alpha_at != NULL ? diagonal : diagonal / 50;
    w->offset = w->how->offset > 0 ? w->how->offset : alpha > 0 ? alpha / 30 : diagonal / 1500;
    w->largest = 0;
    for (k = 0; k < 3; k++) {
        largest = fmax(largest, fmax(fabs(box->low[k]), fabs(box->high[k])));
        w->low[k] = box->low[k] - (margin + 2 * (w->alpha + w->offset));
        w->high[k] = box->high[k] + (margin + 2 * (w->alpha + w->offset));
        w->largest = fmax(w->largest, fmax(fabs(w->low[k]), fabs(w->high[k])));
    }
    w->report->alpha = w->alpha;
    w->report->offset = w->offset;
    w->report->refusal = !(w->alpha > 0) ? PBW_WRAP_NO_SIZE
                       : !(w->offset >= PBWWR__NEAREST * largest) ? PBW_WRAP_NEAR : PBW_WRAP_DONE;
    return w->report->refusal == PBW_WRAP_NO_SIZE ? PBW_DEGENERATE
         : w->report->refusal == PBW_WRAP_NEAR || !(w->alpha <= 1e100 && w->offset <= 1e100 && w->largest <= 1e100)
         ? PBW_ERROR_ARGUMENT : PBW_OK;
}

/* Adds the corners of the box, and of an icosahedron with edges above alpha around each seed that has room for it. */
static int pbwwr__add_artificial(pbwwr__work *w)
{
    const double radius = w->alpha, golden = 0.85065080835203993, short_side = 0.52573111211913361;
    double place[3];
    size_t i, j;
    int k;
    w->report->unused_seeds = 0;
    if (!PBW_RESERVE(&w->memory, w->x, PBWWR__BOX + PBWWR__ICOSAHEDRON * w->how->seed_count)) {
        return 0;
    }
    for (i = 0; i < PBWWR__BOX; i++) {
        for (k = 0; k < 3; k++) {
            w->x.at[i][k] = (i >> k & 1) != 0 ? w->high[k] : w->low[k];
        }
    }
    w->x.count = PBWWR__BOX;
    for (i = 0; i < w->how->seed_count; i++) {
        const double *seed = w->how->seeds + 3 * i;
        int within = 1;
        for (k = 0; k < 3; k++) {
            within &= seed[k] > w->low[k] + radius && seed[k] < w->high[k] - radius;
        }
        if (!within || pbw_surface_closest(&w->surface, seed, radius + w->offset, place) != PBW_NONE) {
            w->report->unused_seeds++;
            continue;
        }
        for (j = 0; j < PBWWR__ICOSAHEDRON; j++) {   /* (0, s, g), with all signs, and turned */
            double *p = w->x.at[w->x.count++];
            const size_t axis = j / 4;
            p[axis] = seed[axis];
            p[(axis + 1) % 3] = seed[(axis + 1) % 3] + ((j & 1) != 0 ? radius : -radius) * short_side;
            p[(axis + 2) % 3] = seed[(axis + 2) % 3] + ((j & 2) != 0 ? radius : -radius) * golden;
        }
    }
    w->artificial = w->x.count;
    return 1;
}

/* Carves the cells inside of icosahedra: nothing is there.  All facets of carved cells, and of the box, are gates. */
static pbw_status pbwwr__open_gates(pbwwr__work *w)
{
    size_t i;
    unsigned k;
    for (i = 0; i < w->cells.count; i++) {
        pbwwr__cell *cell = w->cells.at + i;
        const pbw_index ball = (cell->corner[0] - PBWWR__BOX) / PBWWR__ICOSAHEDRON;
        const double *c[4];
        pbwwr__corners(w, cell, c);
        for (k = 0; k < 4 && cell->corner[k] >= PBWWR__BOX
             && (cell->corner[k] - PBWWR__BOX) / PBWWR__ICOSAHEDRON == ball; k++) {
        }
        cell->carved = k == 4 && !pbwwr__meets(&w->surface, c, w->largest);
    }
    for (i = 0; i < w->cells.count; i++) {
        for (k = 0; k < 4; k++) {
            const pbw_index next = w->cells.at[i].next[k];
            if (!w->cells.at[i].carved && (next == PBW_NONE || w->cells.at[next].carved)
                && !pbwwr__add_gate(w, (pbw_index)i, k, pbwwr__radius(w, (pbw_index)i, k))) {
                return PBW_ERROR_MEMORY;
            }
        }
    }
    return PBW_OK;
}

/* Triangulates the box and the seeds, and carves. */
static pbw_status pbwwr__wrap(pbwwr__work *w)
{
    pbw_mesh mesh;
    pbw_status status;
    size_t i;
    memset(&mesh, 0, sizeof mesh);
    w->cells.count = w->visited.count = w->spare.count = w->born.count = w->gates.count = w->alive = w->kept = 0;
    w->births = 0;
    w->visit = 0;
    if (!pbwwr__add_artificial(w) || !PBW_ZEROS(&w->memory, w->marks, w->x.count)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbw_triangulate(3, (const double *)w->x.at, NULL, w->x.count, &w->options, &mesh);
    if (status == PBW_OK && !pbwwr__take_slots(w, mesh.simplex_count)) {
        status = PBW_ERROR_MEMORY;
    }
    for (i = 0; i < mesh.simplex_count && status == PBW_OK; i++) {
        pbwwr__cell *cell = w->cells.at + i;
        memset(cell, 0, sizeof *cell);
        cell->born = (pbw_index)(i + 1);
        memcpy(cell->corner, mesh.simplices + 4 * i, sizeof cell->corner);
        memcpy(cell->next, mesh.neighbors + 4 * i, sizeof cell->next);
        pbwwr__set_centre(w, cell);
    }
    pbw_free(&mesh);
    status = status != PBW_OK ? status : pbwwr__open_gates(w);
    status = status != PBW_OK ? status : pbwwr__carve(w);
    return status != PBW_OK ? status : pbwwr__make_manifold(w);
}

/* Looks for the least alpha that closes the model: raises it until there is one, and bisects three times.  A ball
   with half the diagonal as its radius passes no hole. */
static pbw_status pbwwr__find_closing(pbwwr__work *w, double *closing)
{
    const pbwsf__box *box = ((const pbwsf__tree *)w->surface.memory)->boxes.at;
    const double most = pbwsf__distance(box->low, box->high) / 2;
    pbw_wrap_report other = *w->report, *const report = w->report;
    double shell = w->alpha, closed = 0, both;
    pbw_status status = PBW_OK;
    int i;
    w->report = &other;
    for (i = 0; status == PBW_OK && i < 3 && (closed > 0 || shell < most);) {
        status = pbwwr__set_lengths(w, closed > 0 ? sqrt(shell * closed) : fmin(1.4 * shell, most));
        status = status != PBW_OK ? status : pbwwr__wrap(w);
        both = status == PBW_OK ? pbwwr__both_sides(w) : 0;
        i += closed > 0;
        if (w->late) {                               /* what was found counts */
            w->cancelled = w->late = 0;
            status = PBW_OK;
            break;
        }
        if (both > PBWWR__CLOSED) {
            shell = w->alpha;
        } else if (status == PBW_OK && !w->cancelled) {
            closed = w->alpha;
        }
    }
    w->report = report;
    *closing = closed;
    return status;
}

static pbw_status pbwwr__run(pbwwr__work *w, const pbw_wrap_input *in, pbw_wrap_result *wrap)
{
    pbw_wrap_report *const r = w->report;
    const double until = w->how->seconds > 0 ? (double)clock() + w->how->seconds * CLOCKS_PER_SEC : 0;
    double start = (double)clock();
    pbw_status status = pbwwr__load(w, in);
    r->seconds[0] = ((double)clock() - start) / CLOCKS_PER_SEC;
    start = (double)clock();
    w->until = until;
    status = status != PBW_OK ? status : pbwwr__set_lengths(w, w->how->alpha);
    status = status != PBW_OK ? status : pbwwr__wrap(w);
    w->until = 0;
    r->refusal = w->late ? PBW_WRAP_LATE : r->refusal;
    r->seconds[1] = ((double)clock() - start) / CLOCKS_PER_SEC;
    start = (double)clock();
    w->done = fmax(w->done, 0.9);
    status = status == PBW_OK && w->how->fill > 0 ? pbwwr__fill(w) : status;
    status = status != PBW_OK ? status : pbwwr__output(w, wrap);
    status = status != PBW_OK ? status : pbwwr__count_open(w, in);
    if (status == PBW_OK && (r->open_edges > 0 || in->triangle_count == 0)) {
        r->both_sides = pbwwr__both_sides(w);
        r->shell = r->both_sides > PBWWR__SHELL;
    }
    if (status == PBW_OK && r->shell && w->how->closing && w->how->alpha_at == NULL) {
        w->until = until;
        status = pbwwr__find_closing(w, &r->closing);
        w->until = 0;
    }
    r->seconds[2] = ((double)clock() - start) / CLOCKS_PER_SEC;
    w->done = 1;
    return status != PBW_OK ? status : pbwwr__progress(w, PBW_STAGE_WORK, 0) ? PBW_CANCELLED : PBW_OK;
}

/* The caller's threads and job system, memory that counts in the work's, and its progress. */
static void pbwwr__set_options(pbwwr__work *w, const pbw_options *options)
{
    memset(&w->options, 0, sizeof w->options);
    w->caller = options;
    if (options != NULL) {
        w->options.threads = options->threads;
        w->options.run = options->run;
        w->options.run_user = options->run_user;
        w->options.resize = options->resize;
        w->options.resize_user = options->resize_user;
        w->options.memory_limit = options->memory_limit;
    }
    pbw_memory_start(&w->memory, &w->options);
    pbw_memory_nest(&w->memory, &w->options);
    w->options.progress = pbwwr__progress;
    w->options.progress_user = w;
}

/* Whether there are arrays where counts are above 0, and numbers where they may be. */
static pbw_status pbwwr__check(const pbw_wrap_input *in, const pbw_wrap_options *how)
{
    const size_t most = PBW_NONE / 3;
    if (in == NULL || (in->point_count > 0 && in->points == NULL)
        || (in->triangle_count > 0 && in->triangles == NULL) || (in->segment_count > 0 && in->segments == NULL)
        || (in->single_count > 0 && in->singles == NULL) || (how->seed_count > 0 && how->seeds == NULL)
        || !(how->alpha >= 0 && how->offset >= 0 && how->fill >= 0 && how->most >= 0 && how->seconds >= 0)) {
        return PBW_ERROR_ARGUMENT;
    }
    return in->triangle_count > most || in->segment_count > most || in->single_count > most
        || in->triangle_count + in->segment_count + in->single_count > most ? PBW_ERROR_TOO_LARGE : PBW_OK;
}

PBWDEF pbw_status pbw_wrap(const pbw_wrap_input *input, const pbw_wrap_options *how, const pbw_options *options,
                           pbw_wrap_result *wrap, pbw_wrap_report *report)
{
    pbw_wrap_options plain;
    pbw_wrap_report own;
    pbwwr__work w;
    pbw_options shared;
    pbw_threads *threads;
    pbw_status status = PBW_OK;
    size_t i;
    memset(&w, 0, sizeof w);
    memset(&plain, 0, sizeof plain);
    w.how = how != NULL ? how : &plain;
    w.report = report != NULL ? report : &own;
    memset(w.report, 0, sizeof *w.report);
    if (wrap != NULL) {
        memset(wrap, 0, sizeof *wrap);
    }
    status = wrap == NULL ? PBW_ERROR_ARGUMENT : pbwwr__check(input, w.how);
    if (status != PBW_OK) {
        return status;
    }
    if (input->triangle_count + input->segment_count + input->single_count == 0) {
        w.report->refusal = PBW_WRAP_EMPTY;
        return PBW_DEGENERATE;
    }
    for (i = 0; i < 3 * w.how->seed_count; i++) {
        status = fabs(w.how->seeds[i]) <= 1e300 ? status : PBW_ERROR_NOT_FINITE;
    }
    threads = pbw_threads_start(options, (size_t)1 << 20, &shared);          /* for some hundred short rounds */
    pbwwr__set_options(&w, &shared);
    status = status != PBW_OK ? status : pbwwr__run(&w, input, wrap);
    pbwwr__unload(&w);
    PBW_RELEASE(&w.memory, w.x);
    PBW_RELEASE(&w.memory, w.cells);
    PBW_RELEASE(&w.memory, w.marks);
    PBW_RELEASE(&w.memory, w.spare);
    PBW_RELEASE(&w.memory, w.visited);
    PBW_RELEASE(&w.memory, w.star);
    PBW_RELEASE(&w.memory, w.born);
    PBW_RELEASE(&w.memory, w.gates);
    PBW_RELEASE(&w.memory, w.later);
    PBW_RELEASE(&w.memory, w.cavities);
    PBW_RELEASE(&w.memory, w.verdicts);
    pbw_threads_stop(threads);
    if (status != PBW_OK) {
        pbw_wrap_free(wrap);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>solid        Good tetrahedra in a wrap; distances.
   In: elements.  Out: tetrahedra, and how far their boundary and the elements are apart.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwwr__far {                /* places of triangles, and the surface that they are far from */
    const pbw_surface *of, *from;
    int per;                               /* places a triangle: 3 corners, 1 centroid, 3 middles of edges */
    double *block;                         /* the largest distance of each block */
} pbwwr__far;

enum { PBWWR__BLOCK = 256 };

static pbw_status pbwwr__find_far(void *arg, size_t from, size_t to)
{
    static const double weights[7][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1. / 3, 1. / 3, 1. / 3 },
                                          { .5, .5, 0 }, { 0, .5, .5 }, { .5, 0, .5 } };
    const pbwwr__far *away = (const pbwwr__far *)arg;
    double *most = away->block + from / PBWWR__BLOCK;
    int i, j, k;
    for (*most = 0; from < to; from++) {
        for (i = 0; i < away->per; i++) {
            double p[3] = { 0, 0, 0 }, q[3];
            for (j = 0; j < 3; j++) {
                for (k = 0; k < 3; k++) {
                    p[k] += weights[i][j] * pbwsf__corner(away->of, (pbw_index)from, j)[k];
                }
            }
            (void)pbw_surface_closest(away->from, p, HUGE_VAL, q);
            *most = fmax(*most, pbwsf__distance(p, q));
        }
    }
    return PBW_OK;
}

static pbw_status pbwwr__farthest(pbwwr__work *w, const pbw_surface *of, const pbw_surface *from, int per,
                                  double *distance)
{
    pbwsf__numbers blocks = { NULL, 0, 0 };
    pbwwr__far away;
    pbw_status status;
    size_t i;
    if (!PBW_ZEROS(&w->memory, blocks, of->triangle_count / PBWWR__BLOCK + 1)) {
        return PBW_ERROR_MEMORY;
    }
    away.of = of;
    away.from = from;
    away.per = per;
    away.block = blocks.at;
    status = pbw_for(&w->options, of->triangle_count, PBWWR__BLOCK, pbwwr__find_far, &away);
    for (i = 0, *distance = 0; i < blocks.count; i++) {
        *distance = fmax(*distance, blocks.at[i]);
    }
    PBW_RELEASE(&w->memory, blocks);
    return status;
}

PBWDEF pbw_status pbw_wrap_distance(const pbw_wrap_input *input, const double *points, size_t point_count,
                                    const pbw_index *facets, size_t facet_count, const pbw_options *options,
                                    double distance[2])
{
    pbw_wrap_options plain;
    pbw_surface surface;
    pbwwr__work w;
    pbw_status status;
    memset(&w, 0, sizeof w);
    memset(&plain, 0, sizeof plain);
    memset(&surface, 0, sizeof surface);
    status = distance == NULL || facet_count == 0 ? PBW_ERROR_ARGUMENT : pbwwr__check(input, &plain);
    if (status != PBW_OK || input->triangle_count + input->segment_count + input->single_count == 0) {
        return status != PBW_OK ? status : PBW_ERROR_ARGUMENT;
    }
    pbwwr__set_options(&w, options);
    status = pbwwr__load(&w, input);
    status = status != PBW_OK ? status
           : pbw_surface_create(points, point_count, facets, facet_count, &w.options, &surface);
    status = status != PBW_OK ? status : pbwwr__farthest(&w, &surface, &w.surface, 7, distance);
    status = status != PBW_OK ? status : pbwwr__farthest(&w, &w.surface, &surface, 4, distance + 1);
    pbw_surface_free(&surface);
    pbwwr__unload(&w);
    return status;
}

typedef struct pbwwr__solid {              /* the calls of pbw_wrap_solid */
    const pbw_wrap_input *input;
    const pbw_wrap_solid_options *how;
    pbw_wrap_solid_report *report;
    const pbw_options *caller;
    pbw_memory memory;
    pbw_options inner, lasting;            /* for results that end with the call, and for the mesh */
    double until;                          /* processor time; 0 = no limit */
    double from, to, done;                 /* the call's part of the progress */
} pbwwr__solid;

static int pbwwr__part_progress(void *user, pbw_stage stage, double done)
{
    pbwwr__solid *s = (pbwwr__solid *)user;
    (void)stage;
    s->done = fmax(s->done, s->from + (s->to - s->from) * fmin(done, 1));
    return s->caller != NULL && s->caller->progress != NULL
        && s->caller->progress(s->caller->progress_user, PBW_STAGE_WORK, s->done) != 0;
}

/* Begins a stage, which ends at `to` of the progress.  Returns the seconds that are left for it, 0 = no limit. */
static double pbwwr__begin(pbwwr__solid *s, const char *name, double to)
{
    s->from = s->to;
    s->to = to;
    if (s->how->stage != NULL) {
        *s->how->stage = name;
    }
    s->lasting.memory_limit = pbw_memory_left(&s->memory);
    return s->until > 0 ? fmax((s->until - (double)clock()) / CLOCKS_PER_SEC, 1e-9) : 0;
}

static void pbwwr__start_solid(pbwwr__solid *s, const pbw_options *options)
{
    pbwwr__work w;                                   /* for its options */
    memset(&w, 0, sizeof w);
    pbwwr__set_options(&w, options);
    s->caller = options;
    s->until = s->how->seconds > 0 ? (double)clock() + s->how->seconds * CLOCKS_PER_SEC : 0;
    s->lasting = w.options;
    s->lasting.resize = options != NULL ? options->resize : NULL;
    s->lasting.resize_user = options != NULL ? options->resize_user : NULL;
    s->lasting.progress = pbwwr__part_progress;
    s->lasting.progress_user = s;
    pbw_memory_start(&s->memory, options);
    s->inner = s->lasting;
    pbw_memory_nest(&s->memory, &s->inner);
}

/* The diagonal of the elements' box; 1 where ids or coordinates are wrong, which the wrap refuses. */
static double pbwwr__diagonal(const pbw_wrap_input *in)
{
    const pbw_index *const ids[3] = { in->triangles, in->segments, in->singles };
    const size_t count[3] = { 3 * in->triangle_count, 2 * in->segment_count, in->single_count };
    double low[3] = { HUGE_VAL, HUGE_VAL, HUGE_VAL }, high[3] = { -HUGE_VAL, -HUGE_VAL, -HUGE_VAL }, diagonal;
    size_t i, j, k;
    for (i = 0; i < 3; i++) {
        for (j = 0; j < count[i] && ids[i] != NULL; j++) {
            for (k = 0; k < 3 && ids[i][j] < in->point_count; k++) {
                low[k] = fmin(low[k], in->points[3 * (size_t)ids[i][j] + k]);
                high[k] = fmax(high[k], in->points[3 * (size_t)ids[i][j] + k]);
            }
        }
    }
    diagonal = pbwsf__distance(low, high);
    return diagonal < HUGE_VAL ? diagonal : 1;
}

/* Makes the wrap, with a larger alpha where that closes the model. */
static pbw_status pbwwr__wrap_to_fill(pbwwr__solid *s, pbw_wrap_result *wrap)
{
    const int given = s->how->wrap.alpha > 0 || s->how->wrap.alpha_at != NULL;
    pbw_wrap_options how = s->how->wrap;
    pbw_wrap_report *const r = &s->report->wrap;
    double size = s->how->size;
    pbw_status status;
    size = size > 0 ? size : fmax(pbwwr__diagonal(s->input) / 40, how.alpha_at == NULL ? 2 * how.alpha : 0);
    how.alpha = how.alpha > 0 ? how.alpha : size / 2;
    how.offset = how.offset > 0 ? how.offset : fmin(size / 8, how.alpha / 2);
    how.fill = size;
    how.closing = 1;
    how.seconds = pbwwr__begin(s, "wrap", 0.3);
    status = pbw_wrap(s->input, &how, &s->inner, wrap, r);
    if (status == PBW_OK && !given && r->closing > 0
        && (r->closing < PBWWR__RAISED * r->alpha || s->input->triangle_count == 0)) {
        const double shell = r->alpha;
        pbw_wrap_free(wrap);
        how.alpha = r->closing;
        how.fill = size = s->how->size > 0 ? size : fmax(size, 2 * how.alpha);
        how.seconds = pbwwr__begin(s, "wrap", 0.4);
        status = pbw_wrap(s->input, &how, &s->inner, wrap, r);
        s->report->raised = shell;
    }
    s->report->size = size;
    s->report->points = wrap->point_count;
    s->report->facets = wrap->facet_count;
    s->report->tets = wrap->tet_count;
    s->report->closed = s->input->triangle_count > 0 && r->open_edges == 0
                     && s->input->segment_count + s->input->single_count == 0;
    return status;
}

static void pbwwr__to_model(void *user, double point[3])
{
    double place[3];
    if (pbw_surface_closest((const pbw_surface *)user, point, HUGE_VAL, place) != PBW_NONE) {
        memcpy(point, place, sizeof place);
    }
}

/* Improves the tetrahedra.  Boundary points slide on the wrap, which has no sharp edges; if the model is closed, they
   are first smoothed on that. */
static pbw_status pbwwr__improve(pbwwr__solid *s, const pbw_wrap_result *wrap, pbw_tets *mesh)
{
    const pbw_wrap_input *in = s->input;
    const double start = (double)clock();
    pbw_improve_options how;
    pbw_surface model;
    pbw_status status = PBW_OK;
    pbw_tets tets;
    memset(&model, 0, sizeof model);
    memset(&how, 0, sizeof how);
    memset(&tets, 0, sizeof tets);
    tets.points = wrap->points;
    tets.point_count = wrap->point_count;
    tets.corners = wrap->corners;
    tets.tet_count = wrap->tet_count;
    tets.neighbors = wrap->neighbors;
    how.target = s->how->target;
    how.feature_angle = 180;
    if (s->report->closed && !s->how->stay) {
        status = pbw_surface_create(in->points, in->point_count, in->triangles, in->triangle_count, &s->inner,
                                    &model);
        how.project = pbwwr__to_model;
        how.project_user = &model;
        how.rounds = 10;
    }
    how.seconds = pbwwr__begin(s, "improve", 0.9);
    status = status != PBW_OK ? status : pbw_improve(&tets, &how, &s->lasting, mesh, &s->report->improve);
    s->memory.used += status == PBW_OK ? pbwim__result_bytes(mesh) : 0;
    s->report->late = s->until > 0 && (double)clock() >= s->until;
    s->report->seconds[0] = ((double)clock() - start) / CLOCKS_PER_SEC;
    pbw_surface_free(&model);
    return status;
}

/* Measures how far the mesh's boundary and the elements are apart. */
static pbw_status pbwwr__measure_mesh(pbwwr__solid *s, const pbw_tets *mesh)
{
    PBW_ARRAY(pbw_index) facets = { NULL, 0, 0 };
    pbw_status status = PBW_OK;
    size_t i, k;
    for (i = 0; i < 4 * mesh->tet_count && status == PBW_OK; i++) {
        for (k = 0; k < 3 && mesh->neighbors[i] == PBW_NONE && status == PBW_OK; k++) {
            status = PBW_PUSH(&s->memory, facets, mesh->corners[i / 4 * 4 + PBW_FACET_CORNER(i % 4, k)])
                   ? PBW_OK : PBW_ERROR_MEMORY;
        }
    }
    status = status != PBW_OK ? status
           : pbw_wrap_distance(s->input, mesh->points, mesh->point_count, facets.at, facets.count / 3, &s->inner,
                               s->report->after);
    PBW_RELEASE(&s->memory, facets);
    return status;
}

PBWDEF pbw_status pbw_wrap_solid(const pbw_wrap_input *input, const pbw_wrap_solid_options *how,
                                 const pbw_options *options, pbw_tets *mesh, pbw_wrap_solid_report *report)
{
    pbw_wrap_solid_options plain;
    pbw_wrap_solid_report own;
    pbw_wrap_result wrap;
    pbwwr__solid s;
    pbw_status status;
    double start;
    memset(&s, 0, sizeof s);
    memset(&plain, 0, sizeof plain);
    memset(&wrap, 0, sizeof wrap);
    s.input = input;
    s.how = how != NULL ? how : &plain;
    s.report = report != NULL ? report : &own;
    memset(s.report, 0, sizeof *s.report);
    s.report->before[0] = s.report->before[1] = s.report->after[0] = s.report->after[1] = -1;
    if (mesh != NULL) {
        memset(mesh, 0, sizeof *mesh);
    }
    status = mesh == NULL || !(s.how->size >= 0 && s.how->target >= 0 && s.how->seconds >= 0) ? PBW_ERROR_ARGUMENT
           : pbwwr__check(input, &s.how->wrap);
    if (status != PBW_OK) {
        return status;
    }
    pbwwr__start_solid(&s, options);
    status = pbwwr__wrap_to_fill(&s, &wrap);
    start = (double)clock();
    if (status == PBW_OK && !(s.until > 0 && start >= s.until)) {
        status = pbw_wrap_distance(input, wrap.points, wrap.point_count, wrap.facets, wrap.facet_count, &s.inner,
                                   s.report->before);
    }
    s.report->seconds[1] = ((double)clock() - start) / CLOCKS_PER_SEC;
    status = status != PBW_OK ? status : pbwwr__improve(&s, &wrap, mesh);
    pbw_wrap_free(&wrap);
    start = (double)clock();
    (void)pbwwr__begin(&s, "measure", 1);
    if (status == PBW_OK && !(s.until > 0 && start >= s.until)) {
        status = pbwwr__measure_mesh(&s, mesh);
    }
    s.report->seconds[1] += ((double)clock() - start) / CLOCKS_PER_SEC;
    if (status == PBW_OK && pbwwr__part_progress(&s, PBW_STAGE_WORK, 1)) {
        status = PBW_CANCELLED;
    }
    if (status != PBW_OK) {
        pbw_tets_free(mesh);
    }
    return status;
}

PBW_CONTRACTION_ON
#endif /* PBWSF__SEAM, PBWIM__SEAM */
#endif /* PBW_WRAP_IMPLEMENTATION */
