/* pbw_fill.h - v0.2.0 - tetrahedra that keep a surface's own triangles - MIT-0

   QUICK START
   In one source file, define PBW_FILL_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, pbw_surface.h and pbw_improve.h, with their implementations in some source file.

       pbw_fill_input input = {0};
       pbw_filled filled = {0};
       pbw_fill_report report;
       input.points = points;        input.point_count = n;          // a closed surface, of one or several shells
       input.triangles = triangles;  input.triangle_count = m;
       if (pbw_fill(&input, NULL, NULL, &filled, &report) != PBW_OK) puts(pbw_fill_refusal(report.refusal));
       // filled.tets.corners: 4 points a tetrahedron;  filled.facet_triangle: the input's triangle of each facet
       pbw_fill_free(&filled);

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>work         the work in progress: tetrahedra and their links, progress, a hash table
     >>signs        exact signs for places that are sums of doubles
     >>vertices     the input's points, and a box around
     >>start        the first triangulation, with a box around
     >>edges        edges of the triangles; which are segments; flat facets
     >>insertion    point location; a point inserted into a Delaunay triangulation
     >>segments     points on segments until all of their pieces are edges
     >>cavities     one side of a facet's cavity, wrapped into tetrahedra
     >>facets       each facet found in the triangulation, or made there
     >>regions      what the facets enclose
     >>exact        points taken off the surface's edges again
     >>diagonals    flat facets cut into the input's triangles
     >>spared       added points inside taken off
     >>inside       points inside, for sizes and shapes
     >>places       points on edges at doubles
     >>result       the caller's arrays
     >>stages       all of it in order

   FUNCTIONS
     pbw_fill          fills a surface with tetrahedra
     pbw_fill_free     frees the result
     pbw_fill_refusal  why a surface is refused, in words

   HOW
   1. A box around the surface is triangulated with the points as they are.  Points that are added on edges later are
      exactly there: where that is at no doubles, coordinates are sums of up to four, and signs are those of the sums.
   2. Edges of the triangles are segments, but for those between coplanar ones.  A segment that is no edge of the
      triangulation gets a point, until all pieces of segments are edges (Si and Gaertner 2005).
   3. Then the constrained Delaunay triangulation exists, and is unique under pbw.h's tie rule (Shewchuk 1998).  Where
      tetrahedra pass through a facet, both sides are filled again: each open face gets the visible vertex of which
      the sphere holds no other.
   4. What the facets enclose are regions: each gets the number of a seed in it; without seeds, what is inside of an
      odd number of nested bodies is kept.
   5. Unless options.conforming, added points are taken off the edges again: the tetrahedra at each are replaced by
      others without it, or a copy of it moves inside (George, Borouchaki and Saltel 2003 move points likewise).  Then
      edges within flat facets are flipped until these consist of the input's triangles.
   6. If sizes or ratios are given, tetrahedra that are too large or too slim get points at the centers of their
      spheres, in rounds; facets stay.
   7. Added points that stay and are at no doubles go to some near them.  Where a tetrahedron turns by that, the point
      is moved a little more, or the tetrahedron and those around are filled again, with a point inside if need be.
   8. With a target, pbw_improve raises the dihedral angles inside, and adds points there (PBW_TETS_FROZEN).

   PROMISES  (tests/test_fill.c guards them)
     exact       points of the input come out as they are, bit for bit, and all tetrahedra are positive, by exact
                 signs, in the coordinates that come out.  The facets are the input's triangles, each once, unless
                 report.refusal is PBW_FILL_POINTS_LEFT, or other points of the input are on triangles: then, and
                 with options.conforming, each triangle, or each flat facet of coplanar ones, is a union of facets
     told        the input's triangle of each facet; why and where an input is refused.  Near misses are no reason
                 to refuse
     same        the same bytes for any number of threads
     bounded     no recursion, and no assert on any input

   DOES NOT  work on several threads, but for the first triangulation, the search for crossings, for missing segments
             and for facets that are there, the last check, and improvement.
             Points that are added on edges and stay, as with options.conforming or on wires, are on them if doubles
             are; else at the nearest ones, or within 2^-42 of the largest coordinate from these.  Where tetrahedra
             become flat by that, as in details that are some last places wide, report.flat_tets counts them.

   CONFIGURATION MACROS
     PBW_FILL_IMPLEMENTATION  in one source file: compile the implementation there
*/
#ifndef PBW_FILL_H
#define PBW_FILL_H
#ifndef PBW_IMPROVE_H
#include "pbw_improve.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbw_fill_input {
    const double *points;                  /* 3 coordinates each; points at one place count as one; points that no
                                              triangle has are kept where they are inside */
    size_t point_count;
    const pbw_index *triangles;            /* 3 ids each, turned any way; an edge may have any number of them */
    size_t triangle_count;
    const pbw_index *numbers;              /* one a triangle: flat facets join triangles of one number only; NULL =
                                              all are alike */
    const pbw_index *segments;             /* 2 ids each: edges that belong to no triangle, as wires; NULL = none */
    size_t segment_count;
    const double *seeds;                   /* 3 coordinates each: places in regions; NULL = none */
    const pbw_index *seed_regions;         /* one a seed: the number of its region, PBW_NONE = a hole */
    size_t seed_count;
} pbw_fill_input;

typedef struct pbw_fill_options {          /* NULL or all zero = best defaults */
    int conforming;                        /* 1: points added on edges stay; 0: they are taken off again */
    int split_flat;                        /* only if conforming; 1: edges between coplanar triangles are kept, too:
                                              each triangle is a union of facets; 0: each flat facet of coplanar
                                              triangles is */
    int nested;                            /* without seeds, 1: all that is enclosed is kept; 0: shells inside of
                                              others bound cavities, shells inside of those regions, and so on */
    int outside;                           /* 1: the outside is kept, too, up to a box five times as wide as the
                                              surface's, as the last region */
    size_t most;                           /* points added to segments, and inside, at most; 0 = 50 million */
    /* Points inside, where edges are longer than wanted, about, or tetrahedra slim: if one of these is given.  Facets
       stay, so tetrahedra at them may be larger. */
    double size;                           /* length of edges; 0 = as size_at says, else it grows from that of the
                                              edges of the surface */
    double (*size_at)(void *user, const double place[3]);      /* the same about a place; 0 = any; NULL */
    void *size_user;
    double growth;                         /* of that length from the surface's edges, per distance, without size and
                                              size_at; 0 = 0.3 */
    double ratio;                          /* of a tetrahedron's circumscribed radius by its shortest edge, at most;
                                              0 = 2 */
    double volume;                         /* of a tetrahedron, at most; 0 = any */
    const double *volumes;                 /* the same of each region, by its number; 0 = any; NULL */
    size_t volume_count;
    pbw_improve_options improve;           /* of the inside, with the facets as they are, if its target is above 0 */
    const char **stage;                    /* gets the name of the stage before its progress is reported: those of
                                              report.seconds; NULL = none */
} pbw_fill_options;

enum {                                     /* why an input is refused, with PBW_DEGENERATE */
    PBW_FILL_FILLED,                       /* it is not */
    PBW_FILL_EMPTY,                        /* nothing is enclosed, and options.outside is 0 */
    PBW_FILL_CROSSING,                     /* triangles or segments meet elsewhere than in common corners and edges */
    PBW_FILL_FLAT,                         /* a triangle has no area */
    PBW_FILL_OPEN,                         /* a triangle has the outside on both sides */
    PBW_FILL_TOO_FINE,                     /* a coordinate is not 0, but below 2^-169 of the box, and an edge needs a
                                              point; or magnitudes differ by more than doubles hold */
    PBW_FILL_SEED,                         /* a seed lies on a facet, or that of a region outside; or two seeds of one
                                              region differ in number */
    PBW_FILL_POINTS_LEFT                   /* the status is PBW_OK, but some points stay on edges, without
                                              options.conforming */
};

enum { PBW_FILL_PLACES = 8 };

typedef struct pbw_fill_report {
    int refusal;                           /* PBW_FILL_FILLED, or why there is no result */
    size_t fault_count;                    /* of that kind */
    pbw_index faults[PBW_FILL_PLACES][2];  /* the first of them.  CROSSING: triangles, PBW_NONE for a segment; FLAT,
                                              OPEN, POINTS_LEFT: a triangle; TOO_FINE: the ends of an edge, or
                                              twice a point; SEED: the seed */
    size_t doubles;                        /* triangles with the corners of an earlier one, left out */
    size_t collapsed;                      /* triangles with two corners at one place, left out */
    size_t segments, facets;               /* edges that are kept, and flat facets */
    size_t missing_segments, missing_facets;         /* of the first triangulation */
    size_t segment_points;                 /* points that were added on segments */
    size_t inner_points;                   /* of the result: added points, inside and on edges */
    size_t inside_points;                  /* of these, for sizes and shapes, before improvement */
    size_t too_large, too_slim;            /* tetrahedra that are so all the same, before improvement */
    size_t regions;                        /* that are kept */
    size_t flat_tets;                      /* without a volume above 0: no doubles between their points, or no place
                                              for these where all tetrahedra around have one */
    pbw_improve_report improve;            /* dihedral angles before and after; zeros without improvement */
    pbw_quality inner;                     /* those of tetrahedra without a point of the surface, after */
    double seconds[10];                    /* of processor time: vertices, triangulate, edges, crossings, segments,
                                              facets, regions, exact, inside, improve */
} pbw_fill_report;

typedef struct pbw_filled {                /* start from {0}; pbw_fill_free when done */
    pbw_tets tets;                         /* points, corners, neighbors, regions, original; patches: the input's
                                              triangle at each facet of the surface.  For pbw_fill_free, not for
                                              pbw_tets_free */
    size_t facet_count;
    const pbw_index *facets;               /* 3 points each, turned out of the region that sides[0] is */
    const pbw_index *facet_triangle;       /* the input's triangle that has it, of a flat facet one of them */
    const pbw_index *facet_corners;        /* 4 t + i, the place of the corner across in tets.corners */
    const pbw_index *sides;                /* 2 a facet: the regions on both sides, the second PBW_NONE outside */
    void *memory;                          /* private */
} pbw_filled;

/* Fills a surface.  how, options and report may be NULL.  filled: overwritten, left empty on failure.  Of options, it
   uses threads, run, resize, memory_limit and progress (PBW_STAGE_WORK).  Returns PBW_DEGENERATE if the input is
   refused, see report.refusal; PBW_ERROR_ARGUMENT for ids out of range; PBW_ERROR_TOO_LARGE if options.most is too
   few; PBW_ERROR_NOT_FINITE; or what pbw_triangulate fails with. */
PBWDEF pbw_status pbw_fill(const pbw_fill_input *input, const pbw_fill_options *how, const pbw_options *options,
                           pbw_filled *filled, pbw_fill_report *report);
PBWDEF void pbw_fill_free(pbw_filled *filled);           /* fine on {0}, fine twice */
PBWDEF const char *pbw_fill_refusal(int refusal);        /* in words; never NULL, never freed */

#ifdef __cplusplus
}
#endif
#endif /* PBW_FILL_H */

#if defined(PBW_FILL_IMPLEMENTATION) && !defined(PBWFILL__IMPLEMENTED)
#define PBWFILL__IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

PBW_CONTRACTION_OFF                        /* fused operations would give other coordinates */

/* ------------------------------------------------------------------------------------------------------
   >>work         The work in progress: tetrahedra and their links, progress, a hash table.
   Holds: tetrahedra in use are positive, but for those of no region from >>exact on, and some in >>places; links of
   both sides agree; those not in use have the corner PBW_NONE and are in `unused`.  Vertices are the input's points,
   eight corners of the box, then points that were added; at[v] is a tetrahedron of v, PBW_NONE for duplicates and
   those that were taken off.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWFILL__STEPS = 22,                /* places on a segment are multiples of 2^-22 of it */
       PBWFILL__PLACE = 4,                 /* numbers of a place: coordinates, and the number of its rest; 0 = none */
       PBWFILL__GRAIN = 512 };            /* items of a range of pbw_for */

typedef PBW_ARRAY(pbw_index) pbwfill__indices;
typedef PBW_ARRAY(double) pbwfill__doubles;

typedef struct pbwfill__rest {             /* of a place that is no triple of doubles */
    double part[3][3];                     /* of each coordinate: what is to be added, the largest part first */
    pbw_index ends[2];                     /* vertices without rests, of an edge that it is on; PBW_NONE: on none */
} pbwfill__rest;

typedef struct pbwfill__tet {
    pbw_index v[4], n[4];                  /* n[i]: across from v[i] */
    pbw_index wall[4];                     /* the facet of the surface across from v[i], or PBW_NONE */
} pbwfill__tet;

typedef struct pbwfill__slot { pbw_index key[3], value; uint32_t stamp; } pbwfill__slot;
typedef struct pbwfill__table {            /* of slots with this stamp, each found by its key */
    PBW_ARRAY(pbwfill__slot) slots;        /* count: those in use; capacity: a power of two */
    uint32_t stamp;
} pbwfill__table;

typedef struct pbwfill__edge {             /* of triangles, or a segment of the input; a < b */
    pbw_index a, b;
    size_t first, count;                   /* range of `sides`: its triangles */
    pbw_index piece;                       /* its first piece; PBW_NONE: between coplanar triangles, no segment */
} pbwfill__edge;

typedef struct pbwfill__piece {            /* of an edge between two points on it */
    pbw_index a, b, edge, next;            /* next: the piece that begins at b, PBW_NONE at the end */
    pbw_index ends[2];                     /* the vertices between which places are exact */
    uint32_t from, to;                     /* where a and b are between them */
} pbwfill__piece;

typedef struct pbwfill__face {             /* at the boundary of a cavity */
    pbw_index v[3];                        /* the cavity is on the positive side */
    pbw_index outside, back;               /* the tetrahedron beyond, PBW_NONE where that is in the cavity, too, and
                                              the number of its corner across */
    pbw_index wall;
    int side;                              /* of the facet's plane */
    pbw_index tet, corner;                 /* that fills the cavity here: its place in `made`, then itself */
    double n[3];                           /* the unit normal, once that has been found */
} pbwfill__face;

typedef struct pbwfill__work {
    pbw_memory memory;
    const pbw_fill_input *input;
    pbw_fill_options how;
    const pbw_options *caller;
    pbw_options options;                   /* the caller's, less what does not concern parts */
    pbw_fill_report *report;
    double from, to, done;                 /* progress: of the present stage, and what was reported last */
    size_t ticks;
    int cancelled, stage;                  /* stage: its number */
    int starved;                           /* memory was short in a function that does not return a status */
    clock_t since;
    int exponent;                          /* coordinates are those of the input times 2^-exponent */
    int has_rests;                         /* places may have rests: no coordinate is too small for them */
    double slack;                          /* by how much rests change differences of coordinates, at most */
    pbwfill__doubles x;                    /* PLACE numbers a vertex */
    PBW_ARRAY(pbwfill__rest) rests;        /* the first is none */
    size_t inputs;                         /* how many vertices are the input's */
    pbwfill__indices canonical;            /* of each of them: the first at its place */
    PBW_ARRAY(pbwfill__tet) tets;
    pbwfill__indices unused, at;
    PBW_ARRAY(uint32_t) seen;              /* of each tetrahedron, against `epoch` */
    uint32_t epoch;
    PBW_ARRAY(unsigned char) touched;      /* of each vertex: its star has changed */
    PBW_ARRAY(unsigned char) noted;        /* by several threads, of each piece or tetrahedron: it has to be mended;
                                              of each facet: it is there */
    PBW_ARRAY(unsigned char) beyond;       /* of each vertex: which faces of a tetrahedron it is beyond */
    pbwfill__indices corners;              /* of the triangles: canonical points */
    PBW_ARRAY(pbwfill__edge) edges;
    pbwfill__indices sides;                /* 3 t + k: the side of triangle t across from its corner k */
    pbwfill__indices edge_of;              /* 3 t + k: its edge */
    pbwfill__indices facet_of;             /* of each triangle */
    pbwfill__indices facet_first, members; /* the triangles of facet f: members[facet_first[f]] to the next's */
    PBW_ARRAY(pbwfill__piece) pieces;
    PBW_ARRAY(unsigned char) narrow;       /* of each vertex: two segments at it are at less than 8 degrees */
    pbwfill__indices ends_of;              /* 2 a vertex on a segment: its piece's `ends`; vertices of segments follow
                                              the box's corners */
    pbwfill__table table, borders, covered;
    pbwfill__table wires;                  /* the pieces of edges that no triangle has: a, b, a < b */
    pbwfill__indices cavity;               /* tetrahedra */
    pbwfill__indices list;                 /* vertices of the cavity, or tetrahedra to be visited */
    PBW_ARRAY(pbwfill__face) faces;
    PBW_ARRAY(pbwfill__tet) made;          /* what is to fill the cavity; links: 4 times the place of another one in
                                              here, plus the corner */
    PBW_ARRAY(signed char) sign;           /* of each vertex: the side of a facet's plane that it is on, where
                                              seen_vertex has the facet's number plus 1; from >>exact on 1 */
    PBW_ARRAY(uint32_t) seen_vertex;       /* in >>places 1: a move was tried, with its tetrahedra as they are */
    pbwfill__indices region;               /* of each tetrahedron */
    pbwfill__indices made_region;          /* of those made; empty: all are of the region of the cavity's first */
} pbwfill__work;

static const double *pbwfill__at(const pbwfill__work *w, pbw_index v)
{
    return w->x.at + PBWFILL__PLACE * (size_t)v;
}

static size_t pbwfill__vertices(const pbwfill__work *w)
{
    return w->x.count / PBWFILL__PLACE;
}

/* Refuses the input, or counts one more reason to. */
static pbw_status pbwfill__refuse(pbwfill__work *w, int refusal, pbw_index a, pbw_index b)
{
    pbw_fill_report *r = w->report;
    if (r->fault_count < PBW_FILL_PLACES) {
        r->faults[r->fault_count][0] = a;
        r->faults[r->fault_count][1] = b;
    }
    r->fault_count++;
    r->refusal = refusal;
    return PBW_DEGENERATE;
}

/* Reports the progress.  Returns 1 if the caller cancels. */
static int pbwfill__ends(pbwfill__work *w)
{
    w->cancelled |= w->caller != NULL && w->caller->progress != NULL
                 && w->caller->progress(w->caller->progress_user, PBW_STAGE_WORK, w->done) != 0;
    return w->cancelled;
}

/* The same within a loop, once in a while: each 256th time, or earlier where other work is added to ticks. */
static int pbwfill__tick(pbwfill__work *w, double share)
{
    if (++w->ticks < 256) {
        return w->cancelled;
    }
    w->ticks = 0;
    w->done = fmax(w->done, w->from + (w->to - w->from) * share);
    return pbwfill__ends(w);
}

static int pbwfill__inner_progress(void *user, pbw_stage stage, double done)
{
    (void)stage;
    (void)done;
    return pbwfill__ends((pbwfill__work *)user);
}

/* Ends the stage before and begins one, which ends at `to` of the progress.  Returns 1 if the caller cancels. */
static int pbwfill__begin(pbwfill__work *w, int stage, const char *name, double to)
{
    const clock_t now = clock();
    w->report->seconds[w->stage] += (double)(now - w->since) / CLOCKS_PER_SEC;
    w->since = now;
    w->stage = stage;
    w->from = w->done = w->to;
    w->to = fmax(to, w->to);
    if (name != NULL && w->how.stage != NULL) {
        *w->how.stage = name;
    }
    return pbwfill__ends(w);
}

/* The options for a call of the library: what it allocates and keeps is freed before this work ends. */
static const pbw_options *pbwfill__inner_options(pbwfill__work *w)
{
    pbw_memory_nest(&w->memory, &w->options);
    w->options.progress = pbwfill__inner_progress;
    w->options.progress_user = w;
    return &w->options;
}

/* ---- the hash table */

static void pbwfill__clear(pbwfill__table *table)
{
    table->slots.count = 0;
    table->stamp++;
    if (table->stamp == 0) {                         /* after 2^32 clearings */
        memset(table->slots.at, 0, table->slots.capacity * sizeof *table->slots.at);
        table->stamp = 1;
    }
}

static pbwfill__slot *pbwfill__find(const pbwfill__table *table, pbw_index a, pbw_index b, pbw_index c)
{
    size_t i = (size_t)pbw_mix(pbw_mix((uint64_t)a << 32 | b) + c);
    for (;; i++) {
        pbwfill__slot *s = table->slots.at + (i & (table->slots.capacity - 1));
        if (s->stamp != table->stamp || (s->key[0] == a && s->key[1] == b && s->key[2] == c)) {
            return s;
        }
    }
}

/* Returns the value of a key, which is PBW_NONE if it is not there. */
static pbw_index pbwfill__look_up(const pbwfill__table *table, pbw_index a, pbw_index b, pbw_index c)
{
    const pbwfill__slot *s = table->slots.count == 0 ? NULL : pbwfill__find(table, a, b, c);
    return s == NULL || s->stamp != table->stamp ? PBW_NONE : s->value;
}

/* Doubles the slots of a table.  Returns 0 without memory, or if the caller cancels. */
static int pbwfill__enlarge(pbwfill__work *w, pbwfill__table *table)
{
    const size_t wanted = table->slots.capacity == 0 ? 64 : 2 * table->slots.capacity;
    pbwfill__table larger;
    size_t i;
    memset(&larger, 0, sizeof larger);
    if (!PBW_FIT(&w->memory, larger.slots, wanted)) {
        return 0;
    }
    for (i = 0; i < wanted && (i % 64 != 0 || !pbwfill__tick(w, 0)); i++) {
        larger.slots.at[i].stamp = 0;
    }
    larger.stamp = 1;
    for (i = 0; i < table->slots.capacity && (i % 64 != 0 || !pbwfill__tick(w, 0)); i++) {
        const pbwfill__slot *from = table->slots.at + i;
        if (from->stamp == table->stamp && table->slots.count > 0) {
            pbwfill__slot *to = pbwfill__find(&larger, from->key[0], from->key[1], from->key[2]);
            *to = *from;
            to->stamp = 1;
        }
    }
    larger.slots.count = table->slots.count;
    if (w->cancelled) {
        PBW_RELEASE(&w->memory, larger.slots);
        return 0;
    }
    PBW_RELEASE(&w->memory, table->slots);
    *table = larger;
    return 1;
}

/* Returns the value of a key, to be changed: PBW_NONE if it was not there, then NULL without memory, or if the caller
   cancels. */
static pbw_index *pbwfill__put(pbwfill__work *w, pbwfill__table *table, pbw_index a, pbw_index b, pbw_index c)
{
    pbwfill__slot *s = table->slots.capacity == 0 ? NULL : pbwfill__find(table, a, b, c);
    if (s == NULL || s->stamp != table->stamp) {
        if (2 * (table->slots.count + 1) > table->slots.capacity) {
            s = pbwfill__enlarge(w, table) ? pbwfill__find(table, a, b, c) : NULL;
        }
        if (s == NULL) {
            return NULL;
        }
        s->key[0] = a, s->key[1] = b, s->key[2] = c;
        s->stamp = table->stamp;
        s->value = PBW_NONE;
        table->slots.count++;
    }
    return &s->value;
}

/* The same for three ids in any order. */
static pbw_index *pbwfill__put_sorted(pbwfill__work *w, pbwfill__table *table, pbw_index a, pbw_index b, pbw_index c)
{
    const pbw_index least = a < b ? (a < c ? a : c) : (b < c ? b : c);
    const pbw_index most = a > b ? (a > c ? a : c) : (b > c ? b : c);
    return pbwfill__put(w, table, least, a ^ b ^ c ^ least ^ most, most);
}

/* ---- tetrahedra */

/* Makes room for more tetrahedra, so that pbwfill__new_tet cannot fail. */
static int pbwfill__reserve(pbwfill__work *w, size_t more)
{
    return more <= w->unused.count
        || (PBW_RESERVE(&w->memory, w->tets, more) && PBW_RESERVE(&w->memory, w->seen, more)
            && w->tets.count + more < PBW_NONE / 4);
}

static pbw_index pbwfill__new_tet(pbwfill__work *w)
{
    if (w->unused.count > 0) {
        return w->unused.at[--w->unused.count];
    }
    w->seen.at[w->seen.count++] = 0;
    return (pbw_index)w->tets.count++;
}

static int pbwfill__drop_tet(pbwfill__work *w, pbw_index t)
{
    w->tets.at[t].v[0] = PBW_NONE;
    return PBW_PUSH(&w->memory, w->unused, t) != 0;
}

static int pbwfill__is_wire(const pbwfill__work *w, pbw_index u, pbw_index v)
{
    return pbwfill__look_up(&w->wires, u < v ? u : v, u < v ? v : u, PBW_NONE) != PBW_NONE;
}

/* Sets the region of a tetrahedron, which may be new.  Returns 0 without memory. */
static int pbwfill__set_region(pbwfill__work *w, pbw_index t, pbw_index region)
{
    while (w->region.count < w->tets.count) {
        if (!PBW_PUSH(&w->memory, w->region, PBW_NONE)) {
            return 0;
        }
    }
    w->region.at[t] = region;
    return 1;
}

/* The number of a corner; 4 if v is none. */
static unsigned pbwfill__corner_of(const pbwfill__tet *t, pbw_index v)
{
    return t->v[0] == v ? 0 : t->v[1] == v ? 1 : t->v[2] == v ? 2 : t->v[3] == v ? 3 : 4;
}

/* The number of the corner of t across from its neighbour. */
static unsigned pbwfill__back(const pbwfill__tet *t, pbw_index neighbor)
{
    return t->n[0] == neighbor ? 0 : t->n[1] == neighbor ? 1 : t->n[2] == neighbor ? 2 : 3;
}

/* The number of the corner of t across from one of its faces; also where t and the tetrahedron behind the face have
   all corners in common, as one of them is turned. */
static unsigned pbwfill__across(const pbwfill__tet *t, const pbw_index v[3])
{
    unsigned k = 0;
    while (t->v[k] == v[0] || t->v[k] == v[1] || t->v[k] == v[2]) {
        k++;
    }
    return k;
}

static void pbwfill__link(pbwfill__work *w, pbw_index t, unsigned i, pbw_index u, unsigned j)
{
    w->tets.at[t].n[i] = u;
    w->tets.at[u].n[j] = t;
}

/* Adds a vertex. */
static int pbwfill__new_vertex(pbwfill__work *w, const double p[PBWFILL__PLACE])
{
    if (!PBW_RESERVE(&w->memory, w->x, PBWFILL__PLACE) || !PBW_PUSH(&w->memory, w->at, PBW_NONE)
        || !PBW_PUSH(&w->memory, w->touched, 0) || !PBW_PUSH(&w->memory, w->beyond, 0)
        || !PBW_PUSH(&w->memory, w->sign, 0)
        || !PBW_PUSH(&w->memory, w->seen_vertex, 0)) {
        return 0;
    }
    memcpy(w->x.at + w->x.count, p, PBWFILL__PLACE * sizeof *p);
    w->x.count += PBWFILL__PLACE;
    return 1;
}

/* ------------------------------------------------------------------------------------------------------
   >>signs        Exact signs for places that are sums of doubles.
   In: places; a coordinate is x[k], plus the parts of its rest.  Out: signs; ties as pbw.h decides them.
   A point on an edge of the input is (1 - t) p + t q, t a multiple of 2^-22: as p and q are doubles, it is the sum of
   four, two of either product.  With few bits, as in models of floats, it is mostly a double, as are other places.
   Holds: where there are rests, coordinates are multiples of 2^-214 below 2^82.  So differences have at most 297
   bits, determinants of degree five, sums of 72 products, at most 5 * 297 + 7; all products are multiples of 2^-1070,
   and nothing under- or overflows.  A sum consists of parts, which ascend, do not overlap, and are not adjacent:
   there is a bit between any two (Shewchuk 1997, "Adaptive precision floating-point arithmetic", theorem 10: sums
   that round to nearest even leave them so).  So there are two bits for each part but one.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWFILL__PARTS = 150 };             /* of a difference, at most; times the degree of other numbers */

typedef struct pbwfill__sum { double *part; int count; } pbwfill__sum;

/* Takes room for a number of a degree out of the pool. */
static pbwfill__sum pbwfill__new_sum(double **pool, int degree)
{
    pbwfill__sum n;
    n.part = *pool;
    n.count = 0;
    *pool += degree * PBWFILL__PARTS;
    return n;
}

static void pbwfill__add(pbwfill__sum *n, double x)
{
    int i, count = 0;
    for (i = 0; i < n->count; i++) {
        const pbw_pair sum = pbw_two_sum(x, n->part[i]);
        x = sum.head;
        if (fabs(sum.tail) > 0) {
            n->part[count++] = sum.tail;
        }
    }
    if (fabs(x) > 0) {
        n->part[count++] = x;
    }
    n->count = count;
}

/* Adds a b or, if the sign is -1, subtracts it. */
static void pbwfill__add_product(pbwfill__sum *n, const pbwfill__sum *a, const pbwfill__sum *b, int sign)
{
    int i, k;
    for (i = 0; i < a->count; i++) {
        for (k = 0; k < b->count; k++) {
            const pbw_pair product = pbw_two_product(sign * a->part[i], b->part[k]);
            pbwfill__add(n, product.tail);
            pbwfill__add(n, product.head);
        }
    }
}

static int pbwfill__sign(const pbwfill__sum *n)
{
    return n->count == 0 ? 0 : n->part[n->count - 1] > 0 ? 1 : -1;
}

/* Takes a number apart: x is near it, and rest gets what x lacks.  x is off by less than 3 u times the number,
   u = 2^-53, and each part of the rest likewise: let b be the last bit of n's largest part.  Sums of the parts below
   are less than b / 2, b / 8, and so on, together 2 b / 3, and the number is at least b / 2. */
static void pbwfill__split_parts(pbwfill__work *w, pbwfill__sum *n, double *x, double rest[3])
{
    int i, j;
    for (i = -1; i < 3; i++) {
        double sum = 0;
        for (j = 0; j < n->count; j++) {
            sum += n->part[j];
        }
        *(i < 0 ? x : rest + i) = sum;
        pbwfill__add(n, -sum);
    }
    w->slack = fmax(w->slack, 2.001 * fabs(rest[0]));        /* two such rests, with all of their parts */
}

/* p's coordinate k less o's. */
static pbwfill__sum pbwfill__difference(const pbwfill__work *w, const double *p, const double *o, int k,
                                           double **pool)
{
    pbwfill__sum n = pbwfill__new_sum(pool, 1);
    int i;
    for (i = 2; i >= 0; i--) {
        pbwfill__add(&n, w->rests.at[(size_t)p[3]].part[k][i]);
        pbwfill__add(&n, -w->rests.at[(size_t)o[3]].part[k][i]);
    }
    pbwfill__add(&n, p[k]);
    pbwfill__add(&n, -o[k]);
    return n;
}

/* Rounds rows[i] = p[i] - o.  size: of each axis, and of the squared length, what bounds them: a difference is off by
   5 u times that: two roundings on each term, and rests beyond their first parts, which are below 3 u of these. */
static void pbwfill__subtract(const pbwfill__work *w, const double *const *p, int count, const double *o,
                              double rows[4][3], double size[4])
{
    const pbwfill__rest *from = w->rests.at + (size_t)o[3];
    int i, k;
    size[0] = size[1] = size[2] = size[3] = 0;
    for (i = 0; i < count; i++) {
        const pbwfill__rest *rest = w->rests.at + (size_t)p[i][3];
        double square = 0;
        for (k = 0; k < 3; k++) {
            const double d = p[i][k] - o[k], more = rest->part[k][0] - from->part[k][0];
            const double most = fabs(d) + fabs(rest->part[k][0]) + fabs(from->part[k][0]);
            rows[i][k] = d + more;
            size[k] = most > size[k] ? most : size[k];
            square += most * most;
        }
        size[3] = square > size[3] ? square : size[3];
    }
}

/* The determinant of the first two columns of rows i and j, and of three rows. */
static double pbwfill__minor2(double rows[4][3], int i, int j)
{
    return rows[i][0] * rows[j][1] - rows[j][0] * rows[i][1];
}

static double pbwfill__minor3(double rows[4][3], int i, int j, int k)
{
    return rows[i][2] * pbwfill__minor2(rows, j, k) - rows[j][2] * pbwfill__minor2(rows, i, k)
         + rows[k][2] * pbwfill__minor2(rows, i, j);
}

/* The same in pairs of doubles.  Errors are at most 7 u^2 of a product and 3 u^2 of the terms of a sum (Joldes,
   Muller and Popescu 2017, "Tight and rigorous error bounds for basic building blocks of double-word arithmetic"):
   8 u^2 for each of them.  A difference counts as three: two sums, and third parts, which are below 9 u^2 of the
   first ones. */
static void pbwfill__subtract_pairs(const pbwfill__work *w, const double *const *p, int count, const double *o,
                                    pbw_pair rows[4][3])
{
    const pbwfill__rest *from = w->rests.at + (size_t)o[3];
    int i, j, k;
    for (i = 0; i < count; i++) {
        const pbwfill__rest *rest = w->rests.at + (size_t)p[i][3];
        for (k = 0; k < 3; k++) {
            rows[i][k] = pbw_two_sum(p[i][k], -o[k]);
            for (j = 0; j < 2; j++) {
                rows[i][k] = pbw_pair_plus(rows[i][k], pbw_two_sum(rest->part[k][j], -from->part[k][j]));
            }
        }
    }
}

static pbw_pair pbwfill__pair_minor3(pbw_pair rows[4][3], int i, int j, int k)
{
    const pbw_pair a = pbw_pair_minor(rows[j][0], rows[j][1], rows[k][0], rows[k][1]);
    const pbw_pair b = pbw_pair_minor(rows[k][0], rows[k][1], rows[i][0], rows[i][1]);
    const pbw_pair c = pbw_pair_minor(rows[i][0], rows[i][1], rows[j][0], rows[j][1]);
    return pbw_pair_plus(pbw_pair_plus(pbw_pair_times(rows[i][2], a), pbw_pair_times(rows[j][2], b)),
                         pbw_pair_times(rows[k][2], c));
}

/* The same exactly: all rows, columns, and minors of two and three rows that leave out those of the index. */
typedef struct pbwfill__exact { pbwfill__sum row[4][3], pair[4][4]; } pbwfill__exact;

static void pbwfill__read_rows(const pbwfill__work *w, const double *const *p, int count, const double *o,
                               pbwfill__exact *e, double **pool)
{
    int i, k;
    for (i = 0; i < count; i++) {
        for (k = 0; k < 3; k++) {
            e->row[i][k] = pbwfill__difference(w, p[i], o, k, pool);
        }
    }
    for (i = 0; i < count; i++) {
        for (k = i + 1; k < count; k++) {
            e->pair[i][k] = pbwfill__new_sum(pool, 2);
            pbwfill__add_product(&e->pair[i][k], &e->row[i][0], &e->row[k][1], 1);
            pbwfill__add_product(&e->pair[i][k], &e->row[k][0], &e->row[i][1], -1);
        }
    }
}

static pbwfill__sum pbwfill__exact_minor3(const pbwfill__exact *e, int i, int j, int k, double **pool)
{
    pbwfill__sum n = pbwfill__new_sum(pool, 3);
    pbwfill__add_product(&n, &e->row[i][2], &e->pair[j][k], 1);
    pbwfill__add_product(&n, &e->row[j][2], &e->pair[i][k], -1);
    pbwfill__add_product(&n, &e->row[k][2], &e->pair[i][j], 1);
    return n;
}

/* Returns the orientation of `count` places, in space (axis: 3) or seen along an axis, if those with the ends of
   edges instead of places on them have no opposite signs, as it is linear in each place; else 2. */
static int pbwfill__sign_of_ends(const pbwfill__work *w, const double *const *p, int count, int axis)
{
    int i, sign = 0, ways = 1, way;
    for (i = 0; i < count; i++) {
        ways *= p[i][3] > 0 ? 2 : 1;
    }
    for (way = 0; way < ways; way++) {
        const double *q[4];
        int s, left = way;
        for (i = 0; i < count; i++) {
            q[i] = p[i];
            if (p[i][3] > 0) {
                const pbw_index end = w->rests.at[(size_t)p[i][3]].ends[left % 2];
                if (end == PBW_NONE) {
                    return 2;
                }
                q[i] = pbwfill__at(w, end);
                left /= 2;
            }
        }
        if (axis < 3) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            const double a[2] = { q[0][u], q[0][v] }, b[2] = { q[1][u], q[1][v] }, c[2] = { q[2][u], q[2][v] };
            s = pbw_orient2(a, b, c);
        } else {
            s = pbw_orient3(q[0], q[1], q[2], q[3]);
        }
        if (s * sign < 0) {
            return 2;
        }
        sign = s != 0 ? s : sign;
    }
    return sign;
}

static int pbwfill__exact_orient(const pbwfill__work *w, const double *const p[4])
{
    double pool[18 * PBWFILL__PARTS], *top = pool;
    pbwfill__exact e;
    pbwfill__sum n;
    pbwfill__read_rows(w, p, 3, p[3], &e, &top);
    n = pbwfill__exact_minor3(&e, 0, 1, 2, &top);
    return -pbwfill__sign(&n);
}

/* pbw_orient3 with rests.  Roundings on a product, as pbw.h counts them: 5 for each of three differences, and 5 more;
   six products: 120 u times the sizes.  In pairs 3 for each difference: 672 u^2. */
static int pbwfill__orient_rests(const pbwfill__work *w, const double *const p[4])
{
    double rows[4][3], size[4], det, bound;
    pbw_pair pairs[4][3];
    int sign;
    pbwfill__subtract(w, p, 3, p[3], rows, size);
    det = pbwfill__minor3(rows, 0, 1, 2);
    bound = 1.4e-14 * size[0] * size[1] * size[2];
    if (det > bound || det < -bound) {
        return det > 0 ? -1 : 1;
    }
    pbwfill__subtract_pairs(w, p, 3, p[3], pairs);
    det = pbwfill__pair_minor3(pairs, 0, 1, 2).head;
    bound = 1e-29 * size[0] * size[1] * size[2];
    sign = det > bound ? -1 : det < -bound ? 1 : pbwfill__sign_of_ends(w, p, 4, 3);
    return sign < 2 ? sign : pbwfill__exact_orient(w, p);
}

static double pbwfill__largest(double a, double b, double c)
{
    const double x = fabs(a), y = fabs(b), z = fabs(c), most = x > y ? x : y;
    return most > z ? most : z;
}

/* The first filter is for all places, without their rests: 8 roundings on each of six products, 48 u times the sizes,
   and six products of three differences that rests change by e change by no more than 6 (x y z - (x - e) (y - e)
   (z - e)), and so by 6 e (x y + y z + z x).  Underflows are below 2^-900. */
static int pbwfill__orient3(const pbwfill__work *w, const double *a, const double *b, const double *c,
                            const double *d)
{
    const double x0 = a[0] - d[0], y0 = a[1] - d[1], z0 = a[2] - d[2];
    const double x1 = b[0] - d[0], y1 = b[1] - d[1], z1 = b[2] - d[2];
    const double x2 = c[0] - d[0], y2 = c[1] - d[1], z2 = c[2] - d[2], e = w->slack;
    const double x = pbwfill__largest(x0, x1, x2) + e, y = pbwfill__largest(y0, y1, y2) + e;
    const double z = pbwfill__largest(z0, z1, z2) + e;
    const double det = z1 * (x0 * y2 - x2 * y0) - z0 * (x1 * y2 - x2 * y1) - z2 * (x0 * y1 - x1 * y0);
    const double bound = 1e-14 * x * y * z + 7 * e * (x * y + (x + y) * z);
    if (bound > 1e-250 && (det > bound || det < -bound)) {
        return det > 0 ? 1 : -1;
    }
    if (a[3] + b[3] + c[3] + d[3] > 0) {
        const double *p[4];
        p[0] = a, p[1] = b, p[2] = c, p[3] = d;
        return pbwfill__orient_rests(w, p);
    }
    return pbw_orient3(a, b, c, d);
}

/* Whether a is lexicographically larger than b. */
static int pbwfill__is_larger(const pbwfill__work *w, const double *a, const double *b)
{
    int k, sign = 0;
    for (k = 0; k < 3 && sign == 0; k++) {
        double pool[PBWFILL__PARTS], *top = pool;
        const pbwfill__sum n = pbwfill__difference(w, a, b, k, &top);
        sign = pbwfill__sign(&n);
    }
    return sign > 0;
}

/* pbw_conflict3 with rests, exactly; ties as in pbw__tie: of the corners with a coefficient that is not 0, and p, the
   lexicographically largest one decides. */
static int pbwfill__exact_conflict(const pbwfill__work *w, const double *const *corner, const double *p)
{
    static const int others[4][3] = { { 1, 2, 3 }, { 0, 2, 3 }, { 0, 1, 3 }, { 0, 1, 2 } };
    double pool[49 * PBWFILL__PARTS], *top = pool;
    const double *largest = p;
    pbwfill__exact e;
    pbwfill__sum sum;
    int i, k, coefficient[4], verdict = 0;
    pbwfill__read_rows(w, corner, 4, p, &e, &top);
    sum = pbwfill__new_sum(&top, 5);
    for (i = 0; i < 4; i++) {
        const int *o = others[i];
        const pbwfill__sum minor = pbwfill__exact_minor3(&e, o[0], o[1], o[2], &top);
        pbwfill__sum lift = pbwfill__new_sum(&top, 2);
        for (k = 0; k < 3; k++) {
            pbwfill__add_product(&lift, &e.row[i][k], &e.row[i][k], 1);
        }
        pbwfill__add_product(&sum, &lift, &minor, i % 2 == 0 ? 1 : -1);
        coefficient[i] = i % 2 == 0 ? pbwfill__sign(&minor) : -pbwfill__sign(&minor);
    }
    if (sum.count > 0) {
        return pbwfill__sign(&sum) > 0;
    }
    for (i = 0; i < 4; i++) {
        if (coefficient[i] != 0 && pbwfill__is_larger(w, corner[i], largest)) {
            largest = corner[i];
            verdict = coefficient[i] > 0;
        }
    }
    return verdict;
}

static double pbwfill__conflict_in_pairs(const pbwfill__work *w, const double *const *corner, const double *p)
{
    static const int others[4][3] = { { 1, 2, 3 }, { 0, 3, 2 }, { 0, 1, 3 }, { 0, 2, 1 } };  /* signs alternate */
    pbw_pair rows[4][3], det = { 0, 0 };
    int i;
    pbwfill__subtract_pairs(w, corner, 4, p, rows);
    for (i = 0; i < 4; i++) {
        const pbw_pair minor = pbwfill__pair_minor3(rows, others[i][0], others[i][1], others[i][2]);
        const pbw_pair lift = pbw_pair_plus(pbw_pair_plus(pbw_pair_times(rows[i][0], rows[i][0]),
                              pbw_pair_times(rows[i][1], rows[i][1])), pbw_pair_times(rows[i][2], rows[i][2]));
        det = pbw_pair_plus(det, pbw_pair_times(lift, minor));
    }
    return det.head;
}

/* pbw_conflict3 with rests.  Roundings on a product: 5 for each difference, which are two in the lift; 3 more in
   that, 5 in the minor, 3 in the sum; 24 products: 864 u times the sizes.  In pairs 3 for each difference:
   4992 u^2. */
static int pbwfill__conflict_rests(const pbwfill__work *w, const double *const *corner, const double *p)
{
    double rows[4][3], size[4], lift[4], det, bound;
    int i;
    pbwfill__subtract(w, corner, 4, p, rows, size);
    for (i = 0; i < 4; i++) {
        lift[i] = rows[i][0] * rows[i][0] + rows[i][1] * rows[i][1] + rows[i][2] * rows[i][2];
    }
    det = (lift[0] * pbwfill__minor3(rows, 1, 2, 3) - lift[1] * pbwfill__minor3(rows, 0, 2, 3))
        + (lift[2] * pbwfill__minor3(rows, 0, 1, 3) - lift[3] * pbwfill__minor3(rows, 0, 1, 2));
    bound = 1e-13 * size[0] * size[1] * size[2] * size[3];
    if (fabs(det) <= bound) {
        det = pbwfill__conflict_in_pairs(w, corner, p);
        bound *= 1e-14;
    }
    return fabs(det) > bound ? det > 0 : pbwfill__exact_conflict(w, corner, p);
}

static int pbwfill__conflict3(const pbwfill__work *w, const double *a, const double *b, const double *c,
                              const double *d, const double *p)
{
    if (a[3] + b[3] + c[3] + d[3] + p[3] > 0) {
        const double *corner[4];
        corner[0] = a, corner[1] = b, corner[2] = c, corner[3] = d;
        return pbwfill__conflict_rests(w, corner, p);
    }
    return pbw_conflict3(a, b, c, d, p, NULL);
}

static int pbwfill__exact_turn(const pbwfill__work *w, const double *const p[3], int u, int v)
{
    double pool[6 * PBWFILL__PARTS], *top = pool;
    pbwfill__sum x[2], y[2], n;
    int i;
    for (i = 0; i < 2; i++) {
        x[i] = pbwfill__difference(w, p[i], p[2], u, &top);
        y[i] = pbwfill__difference(w, p[i], p[2], v, &top);
    }
    n = pbwfill__new_sum(&top, 2);
    pbwfill__add_product(&n, &x[0], &y[1], 1);
    pbwfill__add_product(&n, &x[1], &y[0], -1);
    return pbwfill__sign(&n);
}

/* pbw_orient2 along an axis with rests.  Two products with 2 * 5 + 2 roundings: 24 u times the sizes. */
static int pbwfill__turn_rests(const pbwfill__work *w, const double *const p[3], int axis)
{
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    double rows[4][3], size[4], det, bound;
    int sign;
    pbwfill__subtract(w, p, 2, p[2], rows, size);
    det = rows[0][u] * rows[1][v] - rows[1][u] * rows[0][v];
    bound = 3e-15 * size[u] * size[v];
    sign = det > bound ? 1 : det < -bound ? -1 : pbwfill__sign_of_ends(w, p, 3, axis);
    return sign < 2 ? sign : pbwfill__exact_turn(w, p, u, v);
}

/* On which side of a-b, seen along an axis, c is. */
static int pbwfill__turn(const pbwfill__work *w, const double *a, const double *b, const double *c, int axis)
{
    if (a[3] + b[3] + c[3] > 0) {
        const double *p[3];
        p[0] = a, p[1] = b, p[2] = c;
        return pbwfill__turn_rests(w, p, axis);
    } else {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const double p[2] = { a[u], a[v] }, q[2] = { b[u], b[v] }, r[2] = { c[u], c[v] };
        return pbw_orient2(p, q, r);
    }
}

static int pbwfill__orient(const pbwfill__work *w, pbw_index a, pbw_index b, pbw_index c, pbw_index d)
{
    return pbwfill__orient3(w, pbwfill__at(w, a), pbwfill__at(w, b), pbwfill__at(w, c), pbwfill__at(w, d));
}

/* Whether p is strictly beyond the facet across from corner i. */
static int pbwfill__is_beyond(const pbwfill__work *w, const pbwfill__tet *t, unsigned i, const double *p)
{
    const double *c[4];
    unsigned k;
    for (k = 0; k < 4; k++) {
        c[k] = k == i ? p : pbwfill__at(w, t->v[k]);
    }
    return pbwfill__orient3(w, c[0], c[1], c[2], c[3]) < 0;
}

/* ------------------------------------------------------------------------------------------------------
   >>vertices     The input's points, and a box around.
   In: the input's points.  Out: vertices: those times a power of two, so that the longest side of their box is from
   2^28 on and below 2^29; the corners of a box five times as wide.
   Holds: nothing is rounded.
   ------------------------------------------------------------------------------------------------------ */
/* x times 2^e, for e from -2000 to 2000. */
static double pbwfill__scaled(double x, int e)
{
    const uint64_t bits[2] = { (uint64_t)(1023 + e / 2) << 52, (uint64_t)(1023 + e - e / 2) << 52 };
    double factors[2];                               /* powers of two; ldexp is slow */
    memcpy(factors, bits, sizeof factors);
    return x * factors[0] * factors[1];
}

/* Sets the exponent; low: the box's corner. */
static pbw_status pbwfill__find_scale(pbwfill__work *w, double low[3])
{
    const double *p = w->input->points;
    double high[3] = { -2, -2, -2 }, most = 0, extent = 0;
    size_t i, k;
    int e;
    low[0] = low[1] = low[2] = 2;
    for (i = 0; i < 3 * w->inputs; i++) {
        if (!(fabs(p[i]) < HUGE_VAL)) {
            return PBW_ERROR_NOT_FINITE;
        }
        most = fmax(most, fabs(p[i]));
    }
    (void)frexp(most, &w->exponent);
    for (i = 0; i < 3 * w->inputs; i++) {
        const double y = pbwfill__scaled(p[i], -w->exponent);
        low[i % 3] = fmin(low[i % 3], y);
        high[i % 3] = fmax(high[i % 3], y);
    }
    for (k = 0; k < 3; k++) {
        extent = fmax(extent, high[k] - low[k]);
    }
    if (!(extent > 0)) {
        return pbwfill__refuse(w, PBW_FILL_EMPTY, PBW_NONE, PBW_NONE);
    }
    (void)frexp(extent, &e);
    for (k = 0; k < 3; k++) {
        low[k] = floor(ldexp(low[k], 29 - e));
    }
    w->exponent += e - 29;
    return PBW_OK;
}

/* The place of a vertex in the caller's coordinates. */
static void pbwfill__place(const pbwfill__work *w, const double *x, double out[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        out[k] = pbwfill__scaled(x[k], w->exponent);
    }
}

/* Whether signs with rests are exact for places at such a coordinate, and on edges that end there: its last bit is
   2^-192 or larger, and 2^-22 of that on edges. */
static int pbwfill__is_in_range(double x)
{
    return !(fabs(x) > 0) || (fabs(x) >= ldexp(1, -140) && fabs(x) < ldexp(1, 82));
}

/* Rounds x to what the caller's doubles hold, and to 0 what is too small for signs with rests. */
static void pbwfill__round(const pbwfill__work *w, double x[3])
{
    double out[3];
    int k;
    pbwfill__place(w, x, out);
    for (k = 0; k < 3; k++) {
        x[k] = pbwfill__scaled(out[k], -w->exponent);
        x[k] = w->has_rests && !pbwfill__is_in_range(x[k]) ? 0 : x[k];
    }
}

static pbw_status pbwfill__make_vertices(pbwfill__work *w)
{
    double low[3];
    pbw_status status = pbwfill__find_scale(w, low);
    size_t i, k;
    const size_t count = w->inputs + 8;
    pbwfill__rest none;
    memset(&none, 0, sizeof none);
    if (status != PBW_OK) {
        return status;
    }
    if (!PBW_ZEROS(&w->memory, w->x, PBWFILL__PLACE * count) || !PBW_ZEROS(&w->memory, w->touched, count)
        || !PBW_ZEROS(&w->memory, w->beyond, count)
        || !PBW_ZEROS(&w->memory, w->sign, count) || !PBW_ZEROS(&w->memory, w->seen_vertex, count)
        || !PBW_ZEROS(&w->memory, w->at, count) || !PBW_PUSH(&w->memory, w->rests, none)) {
        return PBW_ERROR_MEMORY;
    }
    w->has_rests = 1;
    for (i = 0; i < w->inputs; i++) {
        for (k = 0; k < 3; k++) {
            const double y = w->input->points[3 * i + k], x = pbwfill__scaled(y, -w->exponent);
            const double back = pbwfill__scaled(x, w->exponent);
            w->x.at[PBWFILL__PLACE * i + k] = x;
            w->has_rests &= pbwfill__is_in_range(x);
            if (back < y || back > y) {
                return pbwfill__refuse(w, PBW_FILL_TOO_FINE, (pbw_index)i, (pbw_index)i);
            }
        }
    }
    for (i = 0; i < 8; i++) {
        for (k = 0; k < 3; k++) {
            w->x.at[PBWFILL__PLACE * (w->inputs + i) + k] = low[k] + (i >> k & 1 ? ldexp(3, 29) : -ldexp(1, 30));
        }
    }
    return PBW_OK;
}

/* ------------------------------------------------------------------------------------------------------
   >>start        The first triangulation, with a box around.
   In: vertices.  Out: tetrahedra, canonical points.
   ------------------------------------------------------------------------------------------------------ */
static pbw_status pbwfill__triangulate(pbwfill__work *w)
{
    const size_t count = pbwfill__vertices(w);
    pbw_mesh mesh;
    pbw_status status;
    size_t i;
    memset(&mesh, 0, sizeof mesh);
    (void)pbwfill__inner_options(w);
    w->options.stride = PBWFILL__PLACE * sizeof *w->x.at;
    status = pbw_triangulate(3, w->x.at, NULL, count, &w->options, &mesh);
    w->options.stride = 0;
    if (status == PBW_OK && !(PBW_ZEROS(&w->memory, w->canonical, w->inputs)
        && PBW_FIT(&w->memory, w->tets, mesh.simplex_count + mesh.simplex_count / 4)
        && PBW_ZEROS(&w->memory, w->seen, mesh.simplex_count))) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        memcpy(w->canonical.at, mesh.canonical, w->inputs * sizeof *mesh.canonical);
        memcpy(w->at.at, mesh.incident, count * sizeof *mesh.incident);
        w->tets.count = mesh.simplex_count;
        for (i = 0; i < mesh.simplex_count && !pbwfill__tick(w, 1); i++) {
            pbwfill__tet *t = w->tets.at + i;
            memcpy(t->v, mesh.simplices + 4 * i, sizeof t->v);
            memcpy(t->n, mesh.neighbors + 4 * i, sizeof t->n);
            memset(t->wall, 0xff, sizeof t->wall);   /* PBW_NONE */
        }
    }
    pbw_free(&mesh);
    return w->cancelled ? PBW_CANCELLED : status;
}

/* ------------------------------------------------------------------------------------------------------
   >>edges        Edges of the triangles; which are segments; flat facets.
   In: the input's triangles.  Out: corners, edges, sides, facets, a piece for each segment, narrow.
   Holds: edges ascend by their ends, and so do not depend on the order of triangles; facets are numbered by their
   first triangles.
   ------------------------------------------------------------------------------------------------------ */
/* Returns the axis to look along at a triangle, so that it has area: 3 if it has none. */
static int pbwfill__axis_of(const pbwfill__work *w, const double *a, const double *b, const double *c)
{
    int axis = 0;
    while (axis < 3 && pbwfill__turn(w, a, b, c, axis) == 0) {
        axis++;
    }
    return axis;
}

/* The product of p - o and q - o. */
static double pbwfill__dot(const double *o, const double *p, const double *q)
{
    return (p[0] - o[0]) * (q[0] - o[0]) + (p[1] - o[1]) * (q[1] - o[1]) + (p[2] - o[2]) * (q[2] - o[2]);
}

static double pbwfill__distance(const double *p, const double *q)
{
    return sqrt(pbwfill__dot(p, q, q));
}

/* Takes over the triangles, and tells in `gone` those with two corners at one place; others without area are
   faults. */
static pbw_status pbwfill__take_triangles(pbwfill__work *w, unsigned char *gone)
{
    const pbw_fill_input *in = w->input;
    pbw_status status = PBW_OK;
    size_t i, k;
    if (!PBW_FIT(&w->memory, w->corners, 3 * in->triangle_count)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < in->triangle_count; i++) {
        const pbw_index *t = in->triangles + 3 * i;
        pbw_index *c = w->corners.at + 3 * i;
        for (k = 0; k < 3; k++) {
            c[k] = w->canonical.at[t[k]];
        }
        gone[i] = c[0] == c[1] || c[1] == c[2] || c[2] == c[0];
        w->report->collapsed += gone[i];
        if (!gone[i] && pbwfill__axis_of(w, pbwfill__at(w, c[0]), pbwfill__at(w, c[1]), pbwfill__at(w, c[2])) == 3) {
            status = pbwfill__refuse(w, PBW_FILL_FLAT, (pbw_index)i, PBW_NONE);
        }
        if (pbwfill__tick(w, 0)) {
            return PBW_CANCELLED;
        }
    }
    w->corners.count = 3 * in->triangle_count;
    return status;
}

/* Sorts sides (3 t + k, behind them the segments of the input) by their edges, then by the corners across. */
static pbw_status pbwfill__sort_sides(pbwfill__work *w, pbw_index *order)
{
    const size_t triangles = w->corners.count / 3, count = 3 * triangles + w->input->segment_count;
    PBW_ARRAY(uint64_t) keys = { NULL, 0, 0 };
    pbwfill__indices first = { NULL, 0, 0 }, second = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i;
    if (PBW_FIT(&w->memory, keys, count) && PBW_FIT(&w->memory, first, count) && PBW_FIT(&w->memory, second, count)) {
        for (i = 0; i < count; i++) {
            keys.at[i] = i < 3 * triangles ? w->corners.at[i] : PBW_NONE;
        }
        status = pbw_sort(keys.at, count, pbwfill__inner_options(w), first.at);
    }
    if (status == PBW_OK) {
        for (i = 0; i < count; i++) {
            const size_t s = first.at[i], t = s - s % 3;
            const pbw_index *wire = s < 3 * triangles ? NULL : w->input->segments + 2 * (s - 3 * triangles);
            const uint64_t a = s < 3 * triangles ? w->corners.at[t + (s + 1) % 3] : w->canonical.at[wire[0]];
            const uint64_t b = s < 3 * triangles ? w->corners.at[t + (s + 2) % 3] : w->canonical.at[wire[1]];
            keys.at[i] = a < b ? a << 32 | b : b << 32 | a;
        }
        status = pbw_sort(keys.at, count, pbwfill__inner_options(w), second.at);
    }
    for (i = 0; status == PBW_OK && i < count; i++) {
        order[i] = first.at[second.at[i]];
    }
    PBW_RELEASE(&w->memory, keys);
    PBW_RELEASE(&w->memory, first);
    PBW_RELEASE(&w->memory, second);
    return status;
}

static void pbwfill__ends_of(const pbwfill__work *w, pbw_index side, pbw_index *a, pbw_index *b)
{
    const size_t s = side, n = w->corners.count, t = s - s % 3;
    const pbw_index p = s < n ? w->corners.at[t + (s + 1) % 3] : w->canonical.at[w->input->segments[2 * (s - n)]];
    const pbw_index q = s < n ? w->corners.at[t + (s + 2) % 3] : w->canonical.at[w->input->segments[2 * (s - n) + 1]];
    *a = p < q ? p : q;
    *b = p < q ? q : p;
}

/* Makes edges of the sorted sides.  gone: 1, triangles that are left out; 2, which it sets, those that have the
   corners of an earlier one. */
static pbw_status pbwfill__make_edges(pbwfill__work *w, const pbw_index *order, unsigned char *gone)
{
    const size_t count = w->corners.count + w->input->segment_count;
    size_t i, j;
    if (!PBW_FIT(&w->memory, w->sides, w->corners.count + 1)
        || !PBW_ZEROS(&w->memory, w->edge_of, w->corners.count + 1)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < count; i = j) {
        pbwfill__edge e;
        pbw_index last = PBW_NONE;
        memset(&e, 0, sizeof e);
        pbwfill__ends_of(w, order[i], &e.a, &e.b);
        e.first = w->sides.count;
        e.piece = PBW_NONE;
        for (j = i; j < count; j++) {
            pbw_index a, b;
            const size_t s = order[j];
            pbwfill__ends_of(w, order[j], &a, &b);
            if (a != e.a || b != e.b) {
                break;
            }
            if (s >= w->corners.count) {
                e.piece = 0;                         /* the caller's segment */
            } else if (gone[s / 3] == 1) {
                continue;
            } else if (w->corners.at[s] == last) {   /* sorted by corner, then by triangle: the first one stays */
                w->report->doubles += gone[s / 3] == 0;
                gone[s / 3] = 2;
            } else {
                last = w->corners.at[s];
                w->sides.at[w->sides.count++] = (pbw_index)s;
                w->edge_of.at[s] = (pbw_index)w->edges.count;
            }
        }
        e.count = w->sides.count - e.first;
        if (!PBW_PUSH(&w->memory, w->edges, e)) {
            return PBW_ERROR_MEMORY;
        }
        if (pbwfill__tick(w, (double)i / (double)count)) {
            return PBW_CANCELLED;
        }
    }
    return PBW_OK;
}

static pbw_index pbwfill__root(pbw_index *tree, pbw_index i)
{
    while (tree[i] != i) {
        i = tree[i] = tree[tree[i]];
    }
    return i;
}

/* Whether an edge lies within a flat facet: between two coplanar triangles, of one number if facets stay as they
   are. */
static int pbwfill__is_flat(const pbwfill__work *w, const pbwfill__edge *e)
{
    const pbw_index *side = w->sides.at + e->first;
    const double *a, *b, *c, *d;
    pbw_index u, v;
    int axis;
    if (e->count != 2 || e->piece != PBW_NONE || (w->how.conforming && (w->how.split_flat
        || (w->input->numbers != NULL && w->input->numbers[side[0] / 3] != w->input->numbers[side[1] / 3])))) {
        return 0;
    }
    u = w->corners.at[side[0]], v = w->corners.at[side[1]];
    a = pbwfill__at(w, e->a), b = pbwfill__at(w, e->b), c = pbwfill__at(w, u), d = pbwfill__at(w, v);
    if (pbwfill__orient3(w, a, b, c, d) != 0) {
        return 0;
    }
    axis = pbwfill__axis_of(w, a, b, c);
    return pbwfill__turn(w, a, b, c, axis) != pbwfill__turn(w, a, b, d, axis);
}

/* Numbers the facets, lists their triangles, and makes a piece of each segment. */
static pbw_status pbwfill__make_facets(pbwfill__work *w, const unsigned char *gone)
{
    const size_t triangles = w->corners.count / 3;
    pbw_index *facet;
    size_t i, facets = 0;
    if (!PBW_ZEROS(&w->memory, w->facet_of, triangles + 1) || !PBW_ZEROS(&w->memory, w->facet_first, triangles + 2)
        || !PBW_FIT(&w->memory, w->members, triangles + 1)) {
        return PBW_ERROR_MEMORY;
    }
    facet = w->facet_of.at;
    for (i = 0; i < triangles; i++) {
        facet[i] = (pbw_index)i;
    }
    for (i = 0; i < w->edges.count; i++) {
        pbwfill__edge *e = w->edges.at + i;
        if (pbwfill__tick(w, 1)) {
            return PBW_CANCELLED;
        }
        if (pbwfill__is_flat(w, e)) {                /* the lower number becomes the root */
            const pbw_index p = pbwfill__root(facet, w->sides.at[e->first] / 3);
            const pbw_index q = pbwfill__root(facet, w->sides.at[e->first + 1] / 3);
            facet[p < q ? q : p] = p < q ? p : q;
        } else if (e->a != e->b && (e->count > 0 || e->piece == 0)) {
            pbwfill__piece piece;
            memset(&piece, 0, sizeof piece);
            piece.a = piece.ends[0] = e->a;
            piece.b = piece.ends[1] = e->b;
            piece.edge = (pbw_index)i;
            piece.next = PBW_NONE;
            piece.to = 1u << PBWFILL__STEPS;
            e->piece = (pbw_index)w->pieces.count;
            if (!PBW_PUSH(&w->memory, w->pieces, piece)) {
                return PBW_ERROR_MEMORY;
            }
        } else {
            e->piece = PBW_NONE;
        }
    }
    w->report->segments = w->pieces.count;
    for (i = 0; i < triangles; i++) {
        facet[i] = pbwfill__root(facet, (pbw_index)i);
    }
    for (i = 0; i < triangles; i++) {                /* roots come first */
        facet[i] = facet[i] != i ? facet[facet[i]] : gone[i] ? PBW_NONE : (pbw_index)facets++;
    }
    w->report->facets = facets;
    return PBW_OK;
}

/* Fills facet_first and members. */
static void pbwfill__list_members(pbwfill__work *w)
{
    const size_t triangles = w->corners.count / 3, facets = w->report->facets;
    size_t i;
    for (i = 0; i < triangles; i++) {
        if (w->facet_of.at[i] != PBW_NONE) {
            w->facet_first.at[w->facet_of.at[i] + 1]++;
        }
    }
    for (i = 0; i < facets; i++) {
        w->facet_first.at[i + 1] += w->facet_first.at[i];
    }
    w->members.count = w->facet_first.at[facets];
    for (i = triangles; i-- > 0;) {                  /* from the end, so that the starts come out */
        if (w->facet_of.at[i] != PBW_NONE) {
            w->members.at[--w->facet_first.at[w->facet_of.at[i] + 1]] = (pbw_index)i;
        }
    }
    for (i = 0; i < facets; i++) {
        w->facet_first.at[i] = w->facet_first.at[i + 1];
    }
    w->facet_first.at[facets] = (pbw_index)w->members.count;
}

/* Marks the vertices with two segments at less than 8 degrees.  It does not look at more than 1000 segments of one:
   circles of 4 degrees around the directions of 822 cover more than the sphere, so that two of them meet. */
static pbw_status pbwfill__find_narrow(pbwfill__work *w)
{
    const double least = 0.99;                       /* the cosine */
    pbwfill__indices first = { NULL, 0, 0 }, others = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, j;
    if (PBW_ZEROS(&w->memory, w->narrow, w->inputs + 1) && PBW_ZEROS(&w->memory, first, w->inputs + 1)
        && PBW_FIT(&w->memory, others, 2 * w->pieces.count + 1)) {
        status = PBW_OK;
        for (i = 0; i < 2 * w->pieces.count; i++) {
            first.at[w->pieces.at[i / 2].ends[i % 2]]++;
        }
        for (i = 0; i < w->inputs; i++) {
            first.at[i + 1] += first.at[i];
        }
        for (i = 2 * w->pieces.count; i-- > 0;) {
            others.at[--first.at[w->pieces.at[i / 2].ends[i % 2]]] = w->pieces.at[i / 2].ends[1 - i % 2];
        }
        for (i = 0; i < w->inputs; i++) {
            const pbw_index *other = others.at + first.at[i];
            const size_t count = first.at[i + 1] - first.at[i];
            const double *p = pbwfill__at(w, (pbw_index)i);
            w->narrow.at[i] = count > 1000;
            w->ticks += w->narrow.at[i] ? 0 : count * count / 16;
            if (pbwfill__tick(w, 1)) {
                status = PBW_CANCELLED;
                break;
            }
            for (j = 0; j < count * count && !w->narrow.at[i]; j++) {
                const double *q = pbwfill__at(w, other[j / count]), *r = pbwfill__at(w, other[j % count]);
                w->narrow.at[i] = j / count < j % count && pbwfill__dot(p, q, r)
                                > least * pbwfill__distance(p, q) * pbwfill__distance(p, r);
            }
        }
    }
    PBW_RELEASE(&w->memory, first);
    PBW_RELEASE(&w->memory, others);
    return status;
}

static pbw_status pbwfill__find_edges(pbwfill__work *w)
{
    pbwfill__indices order = { NULL, 0, 0 };
    PBW_ARRAY(unsigned char) gone = { NULL, 0, 0 };
    pbw_status status = PBW_ZEROS(&w->memory, gone, w->input->triangle_count + 1) ? PBW_OK : PBW_ERROR_MEMORY;
    status = status != PBW_OK ? status : pbwfill__take_triangles(w, gone.at);
    if (status == PBW_OK && !PBW_FIT(&w->memory, order, w->corners.count + w->input->segment_count + 1)) {
        status = PBW_ERROR_MEMORY;
    }
    status = status != PBW_OK ? status : pbwfill__sort_sides(w, order.at);
    status = status != PBW_OK ? status : pbwfill__make_edges(w, order.at, gone.at);
    status = status != PBW_OK ? status : pbwfill__make_facets(w, gone.at);
    PBW_RELEASE(&w->memory, order);
    PBW_RELEASE(&w->memory, gone);
    if (status == PBW_OK) {
        pbwfill__list_members(w);
        status = pbwfill__find_narrow(w);
    }
    return status;
}

/* Copies the coordinates of the input's vertices.  Returns 0 without memory. */
static int pbwfill__pack(pbwfill__work *w, pbwfill__doubles *points)
{
    size_t i;
    if (!PBW_FIT(&w->memory, *points, 3 * w->inputs + 1)) {
        return 0;
    }
    for (i = 0; i < w->inputs; i++) {
        memcpy(points->at + 3 * i, pbwfill__at(w, (pbw_index)i), 3 * sizeof *points->at);
    }
    return 1;
}

/* Refuses triangles that meet. */
static pbw_status pbwfill__check_crossings(pbwfill__work *w)
{
    pbwfill__doubles points = { NULL, 0, 0 };
    pbw_surface_faults faults;
    pbw_status status = pbwfill__pack(w, &points) ? PBW_OK : PBW_ERROR_MEMORY;
    size_t i;
    memset(&faults, 0, sizeof faults);
    status = status != PBW_OK ? status
           : pbw_surface_crossings(points.at, w->inputs, w->corners.at, w->corners.count / 3,
                                   pbwfill__inner_options(w), &faults);
    PBW_RELEASE(&w->memory, points);
    if (status == PBW_OK) {
        for (i = 0; i < faults.crossing_count; i++) {
            status = pbwfill__refuse(w, PBW_FILL_CROSSING, faults.crossings[2 * i], faults.crossings[2 * i + 1]);
        }
    }
    pbw_surface_faults_free(&faults);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>insertion    Point location; a point inserted into a Delaunay triangulation.
   In: a vertex that is in no tetrahedron yet.  Out: the triangulation with it, the Delaunay triangulation under the
   tie rule: the tetrahedra in conflict with the point are connected, and its star replaces them.
   ------------------------------------------------------------------------------------------------------ */
/* Returns a tetrahedron that contains p: steps across facets that p is beyond, the first one that it tries changes
   pseudorandomly, and so ends in any triangulation of the box. */
static pbw_index pbwfill__locate(const pbwfill__work *w, pbw_index t, const double *p)
{
    uint64_t step = 0;
    unsigned i = 0;
    while (i < 4) {
        const unsigned first = (unsigned)(pbw_mix(step++) & 3);
        for (i = 0; i < 4; i++) {
            const unsigned k = (first + i) & 3;
            if (pbwfill__is_beyond(w, w->tets.at + t, k, p)) {
                t = w->tets.at[t].n[k];
                break;
            }
        }
    }
    return t;
}

static int pbwfill__is_in_conflict(const pbwfill__work *w, const pbwfill__tet *t, const double *p)
{
    return pbwfill__conflict3(w, pbwfill__at(w, t->v[0]), pbwfill__at(w, t->v[1]), pbwfill__at(w, t->v[2]),
                              pbwfill__at(w, t->v[3]), p);
}

/* Lists the tetrahedra in conflict with p, from the one that it is in, up to facets; seen: epoch for these, epoch + 1
   for those beside.  Returns 0 without memory, or if the caller cancels. */
static int pbwfill__open_cavity(pbwfill__work *w, pbw_index start, const double *p)
{
    size_t i;
    unsigned k;
    w->epoch += 2;
    w->cavity.count = 0;
    w->seen.at[start] = w->epoch;
    if (!PBW_PUSH(&w->memory, w->cavity, start)) {
        return 0;
    }
    for (i = 0; i < w->cavity.count; i++) {
        if (i % 8 == 7 && pbwfill__tick(w, 0)) {
            return 0;
        }
        for (k = 0; k < 4; k++) {
            const pbwfill__tet *t = w->tets.at + w->cavity.at[i];
            const pbw_index n = t->n[k];
            if (n != PBW_NONE && t->wall[k] == PBW_NONE && w->seen.at[n] < w->epoch) {
                w->seen.at[n] = w->epoch + !pbwfill__is_in_conflict(w, w->tets.at + n, p);
                if (w->seen.at[n] == w->epoch && !PBW_PUSH(&w->memory, w->cavity, n)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Whether the cavity ends across from corner k of its tetrahedron t. */
static int pbwfill__ends_at(const pbwfill__work *w, pbw_index t, unsigned k)
{
    const pbwfill__tet *tet = w->tets.at + t;
    return tet->n[k] == PBW_NONE || tet->wall[k] != PBW_NONE || w->seen.at[tet->n[k]] != w->epoch;
}

/* Makes the tetrahedron of vertex p that replaces t, corner i's; links it to its neighbours so far.  Returns 0
   without memory. */
static int pbwfill__make_tet(pbwfill__work *w, pbw_index t, unsigned i, pbw_index p)
{
    const pbw_index made = pbwfill__new_tet(w), outside = w->tets.at[t].n[i];
    pbwfill__tet *m = w->tets.at + made;
    unsigned k;
    *m = w->tets.at[t];
    m->v[i] = p;
    if (outside != PBW_NONE) {
        w->tets.at[outside].n[pbwfill__back(w->tets.at + outside, t)] = made;
    }
    for (k = 0; k < 4; k++) {
        pbw_index a, b, *other;
        w->at.at[m->v[k]] = made;
        w->touched.at[m->v[k]] = 1;
        if (k == i) {
            continue;
        }
        m->wall[k] = PBW_NONE;
        a = m->v[(i + 1) % 4 == k ? (i + 2) % 4 : (i + 1) % 4];      /* the two corners beside i and k */
        b = m->v[(i + 3) % 4 == k ? (i + 2) % 4 : (i + 3) % 4];
        other = pbwfill__put(w, &w->table, a < b ? a : b, a < b ? b : a, PBW_NONE);
        if (other == NULL) {
            return 0;
        }
        if (*other != PBW_NONE) {
            pbwfill__link(w, made, k, *other / 4, *other % 4);
        }
        *other = 4 * made + k;
    }
    return PBW_PUSH(&w->memory, w->list, made) != 0;
}

/* Puts the star of the vertex, which `list` gets, in the place of the cavity, of which the vertex sees all faces.
   Returns 0 without memory. */
static int pbwfill__make_star(pbwfill__work *w, pbw_index vertex)
{
    size_t i;
    unsigned k;
    int good = pbwfill__reserve(w, 2 * w->cavity.count + 2);         /* its faces, as its tetrahedra are connected */
    w->ticks += w->cavity.count / 4;
    w->list.count = 0;
    pbwfill__clear(&w->table);
    for (i = 0; i < w->cavity.count && good; i++) {
        for (k = 0; k < 4 && good; k++) {
            good = !pbwfill__ends_at(w, w->cavity.at[i], k) || pbwfill__make_tet(w, w->cavity.at[i], k, vertex);
        }
    }
    for (i = 0; i < w->cavity.count && good; i++) {
        good = pbwfill__drop_tet(w, w->cavity.at[i]);
    }
    return good;
}

/* ------------------------------------------------------------------------------------------------------
   >>segments     Points on segments until all of their pieces are edges.
   In: the Delaunay triangulation of the vertices.  Out: one in which every piece of a segment is an edge.
   A piece that is no edge is cut so that the vertices which it passes, and which are in the ball over it, are in the
   balls over neither part: then nothing that was seen keeps these from being edges.  Where no cut does this, the
   middle halves the problem.  The cut would call forth a vertex on a segment that shares an end with this one, that
   vertex the next cut here, and so on: then both get the same distance from that end (Si and Gaertner 2005, "Meshing
   piecewise linear complexes by constrained Delaunay tetrahedralizations").  A segment with narrow angles at both
   ends, as in strips of thin triangles, is first cut in the middle: its halves have one such end each, so that its
   cuts and those of the segments beside it are at equal distances from the same end.
   This ends: a segment has 2^22 - 1 places for cuts, none is taken twice, and without a place the input is
   refused.  The number is smaller than that.  Let f be the least distance of a segment from vertices of the input
   that are not on it, and from segments that share no end with it.  If one of those vertices, or one on those
   segments, is in the ball over a piece, that is longer than 2 f; the cut is at least 1/100 of it away from its ends.
   So these cuts are f / 50 apart: at most 1 + 50 L / f of them are on a segment of length L.  What else is seen is on
   a segment that shares an end, at a distance d from there.  Let x and y be
   those of the piece's ends, a the angle: it is in the ball if (d cos a - x) (y - d cos a) > d^2 sin^2 a, and so
   only if x < d < y, since for y <= d the left side is at most d cos a d (1 - cos a), which is less than d^2 (1 +
   cos a) (1 - cos a). So the cut is at d, and segments that share this end call forth no other distances there.
   (They do where places round by more than about d a^2 / 2, by 1e-5 of a piece: below 0.3 degrees.  How many
   distances pass on from one end of segments to the other has no bound here but that of the places;
   tests/test_fill.c bounds the sum over its parts.)
   ------------------------------------------------------------------------------------------------------ */
/* What is in the ball over a piece: the vertex that sees it under the largest angle, and its place along the piece;
   cuts from low to high leave none in the balls over the parts.  From 0 to 1, from a to b. */
typedef struct pbwfill__sight { pbw_index vertex; double at, low, high; } pbwfill__sight;

/* The tetrahedron at a that the way to b begins in: b is a corner of it if a and b have an edge.  The triangulation
   must be Delaunay: there a walk that steps to facets that b is beyond comes nearer to b (Edelsbrunner 1990). */
static pbw_index pbwfill__toward(const pbwfill__work *w, pbw_index a, pbw_index b)
{
    const double *target = pbwfill__at(w, b);
    pbw_index t = w->at.at[a];
    unsigned k = 0;
    while (k < 4 && pbwfill__corner_of(w->tets.at + t, b) == 4) {
        const pbwfill__tet *tet = w->tets.at + t;
        for (k = 0; k < 4; k++) {
            if (tet->v[k] != a && pbwfill__is_beyond(w, tet, k, target)) {
                t = tet->n[k];
                break;
            }
        }
    }
    return t;
}

/* Whether p, a different point, is exactly on the line through a and b. */
static int pbwfill__is_on_line(const pbwfill__work *w, const double *a, const double *b, const double *p)
{
    return pbwfill__axis_of(w, a, b, p) == 3;
}

/* The tetrahedron behind t, which has not b for a corner, on the segment from a to b: beyond a facet that the segment
   meets and b is beyond. */
static pbw_index pbwfill__step_along(const pbwfill__work *w, pbw_index t, pbw_index a, pbw_index b)
{
    const pbwfill__tet *tet = w->tets.at + t;
    const double *p = pbwfill__at(w, a), *q = pbwfill__at(w, b);
    unsigned i, k;
    for (i = 0; i < 4; i++) {
        int low = 0, high = 0;
        if (!pbwfill__is_beyond(w, tet, i, q)) {
            continue;
        }
        for (k = 0; k < 3; k++) {
            const pbw_index u = tet->v[PBW_FACET_CORNER(i, k)], v = tet->v[PBW_FACET_CORNER(i, (k + 1) % 3)];
            const int s = pbwfill__orient3(w, p, q, pbwfill__at(w, u), pbwfill__at(w, v));
            low |= s < 0;
            high |= s > 0;
        }
        if (!low || !high) {
            return tet->n[i];
        }
    }
    return PBW_NONE;
}

/* Finds what the piece sees of the corners of the tetrahedra that it passes; the vertex is PBW_NONE if that is
   nothing.  Of points on the piece it is the first one from a.  Returns 0 if the piece is an edge.
   With s for the place of a vertex along the piece and h for its distance from there, both by the piece's length, the
   ball over the part from 0 to t does not hold it if s (t - s) <= h^2, and that over the rest likewise. */
static int pbwfill__look_along(const pbwfill__work *w, const pbwfill__piece *piece, pbwfill__sight *sight)
{
    const double *p = pbwfill__at(w, piece->a), *q = pbwfill__at(w, piece->b);
    const double length = pbwfill__distance(p, q), square = length * length;
    pbw_index t = pbwfill__toward(w, piece->a, piece->b);
    double least = 0;
    unsigned k;
    sight->vertex = PBW_NONE;
    sight->low = 0, sight->at = 0.5, sight->high = 1;
    if (pbwfill__corner_of(w->tets.at + t, piece->b) < 4) {
        return 0;
    }
    while (t != PBW_NONE) {
        const pbwfill__tet *tet = w->tets.at + t;
        for (k = 0; k < 4; k++) {
            const double *r = pbwfill__at(w, tet->v[k]);
            double product, cosine, s, h;
            if (tet->v[k] == piece->a || tet->v[k] == piece->b) {
                continue;
            }
            product = pbwfill__dot(r, p, q);
            if (product > 0) {
                continue;
            }
            if (product < 0 && pbwfill__is_on_line(w, p, q, r)) {
                sight->vertex = tet->v[k];
                return 1;
            }
            s = pbwfill__dot(p, r, q) / square;
            h = fmax(0, product / square + s * (1 - s));             /* h^2 */
            sight->low = s < 1 ? fmax(sight->low, s - h / (1 - s)) : sight->low;
            sight->high = s > 0 ? fmin(sight->high, s + h / s) : sight->high;
            cosine = product / (pbwfill__distance(p, r) * pbwfill__distance(q, r));
            if (sight->vertex == PBW_NONE || cosine < least || (!(cosine > least) && tet->v[k] < sight->vertex)) {
                least = cosine;
                sight->vertex = tet->v[k];
                sight->at = s;
            }
        }
        t = pbwfill__corner_of(tet, piece->b) < 4 ? PBW_NONE : pbwfill__step_along(w, t, piece->a, piece->b);
    }
    return 1;
}

/* Where to cut a piece, 0 to 1 from a to b; *near: how far from there will do. */
static double pbwfill__split_at(const pbwfill__work *w, const pbwfill__piece *piece, const pbwfill__sight *sight,
                                double *nearby)
{
    const double least = 0.05;                       /* the shortest part that is cut off */
    const size_t first = w->inputs + 8;
    const uint32_t half = 1u << (PBWFILL__STEPS - 1);
    double t;
    int side;
    *nearby = 1e-5;
    if (sight->vertex != PBW_NONE && w->narrow.at[piece->ends[0]] && w->narrow.at[piece->ends[1]]
        && piece->from < half && piece->to > half) {
        return 0.5;
    }
    for (side = 0; side < 2 && sight->vertex != PBW_NONE && sight->vertex >= first; side++) {
        const pbw_index *ends = w->ends_of.at + 2 * (sight->vertex - first), end = piece->ends[side];
        const double *c = pbwfill__at(w, end), *r = pbwfill__at(w, sight->vertex), *from, *to;
        if (ends[0] != end && ends[1] != end) {
            continue;
        }
        from = pbwfill__at(w, side == 0 ? piece->a : piece->b);
        to = pbwfill__at(w, side == 0 ? piece->b : piece->a);
        t = (pbwfill__distance(c, r) - pbwfill__distance(c, from)) / pbwfill__distance(from, to);
        return !(t > 0 && t < 1) ? 0.5 : side == 0 ? t : 1 - t;
    }
    t = fmax(sight->low, fmin(sight->high, sight->at));
    if (!(sight->low < sight->high && t >= least && t <= 1 - least)) {
        t = 0.5;
        *nearby = 0.04;
    } else {
        *nearby = fmax(*nearby, fmin(0.04, fmin(t - sight->low, sight->high - t)));
    }
    return t;
}

/* Cuts piece i at a vertex, the place `at` between its ends.  Returns the new piece, behind it; PBW_NONE without
   memory. */
static pbw_index pbwfill__cut(pbwfill__work *w, pbw_index i, pbw_index vertex, uint32_t at)
{
    pbwfill__piece next = w->pieces.at[i];
    const pbw_index made = (pbw_index)w->pieces.count;
    next.a = vertex;
    next.from = at;
    if (!PBW_PUSH(&w->memory, w->pieces, next)) {
        return PBW_NONE;
    }
    w->pieces.at[i].b = vertex;
    w->pieces.at[i].to = at;
    w->pieces.at[i].next = made;
    return made;
}

/* Cuts piece i at a point of the input that lies on it: both parts have ends of their own then. */
static pbw_index pbwfill__cut_at_input(pbwfill__work *w, pbw_index i, pbw_index vertex)
{
    const pbw_index made = pbwfill__cut(w, i, vertex, 0);
    if (made != PBW_NONE) {
        pbwfill__piece *p = w->pieces.at + i, *q = w->pieces.at + made;
        p->ends[1] = q->ends[0] = vertex;
        p->to = q->to = 1u << PBWFILL__STEPS;
    }
    return made;
}

/* Whether p + t (q - p), which x gets, is a triple of doubles, as no step rounds.  t is a multiple of 2^-22, so that
   errors of products show: those of differences from 1e-250 on do not underflow. */
static int pbwfill__between(const double *p, const double *q, double t, double x[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        const pbw_pair d = pbw_two_sum(q[k], -p[k]), m = pbw_two_product(t, d.head), sum = pbw_two_sum(p[k], m.head);
        if (fabs(d.tail) > 0 || fabs(m.tail) > 0 || fabs(sum.tail) > 0
            || (fabs(d.head) > 0 && fabs(d.head) < 1e-250)) {
            return 0;
        }
        x[k] = sum.head;
    }
    return 1;
}

/* The same for any doubles in range: rest gets what x lacks. */
static void pbwfill__between_exactly(pbwfill__work *w, const double *p, const double *q, double t, double x[3],
                                     pbwfill__rest *rest)
{
    double parts[8];                                 /* of five sums */
    pbwfill__sum n;
    int k;
    n.part = parts;
    for (k = 0; k < 3; k++) {
        const pbw_pair d = pbw_two_sum(q[k], -p[k]), m = pbw_two_product(t, d.head), l = pbw_two_product(t, d.tail);
        n.count = 0;
        pbwfill__add(&n, l.tail), pbwfill__add(&n, l.head), pbwfill__add(&n, m.tail), pbwfill__add(&n, m.head);
        pbwfill__add(&n, p[k]);
        pbwfill__split_parts(w, &n, x + k, rest->part[k]);
    }
}

/* Chooses the coarsest place near `want`, 0 to 1, in a piece, a triple of doubles if one of them is, or else the
   nearest, and adds the vertex there; in the middle if that is an end.  Doubles may be farther if they stay.  Returns
   the place; 0 if there is none, PBW_NONE without memory. */
static uint32_t pbwfill__add_split(pbwfill__work *w, const pbwfill__piece *piece, double want, double nearby)
{
    const double span = (double)(piece->to - piece->from), middle = (double)piece->from + want * span;
    const double *p = pbwfill__at(w, piece->ends[0]), *q = pbwfill__at(w, piece->ends[1]);
    double x[PBWFILL__PLACE] = { 0, 0, 0, 0 }, best = 0;
    int e, rank = 0;                                 /* 3: near and doubles, 2: near, 1: the nearest */
    for (e = PBWFILL__STEPS; e >= -1 && rank < 3; e--) {
        const double step = ldexp(1, e);
        const double at = e >= 0 ? floor(middle / step + 0.5) * step : floor((double)piece->from + span / 2);
        const double off = fabs(at - middle) / span;
        if (at > piece->from && at < piece->to && (e >= 0 || rank == 0)) {
            const int doubles = pbwfill__between(p, q, at * ldexp(1, -PBWFILL__STEPS), x);
            const int other = !doubles && !w->has_rests ? 0
                            : off <= (doubles && w->how.conforming ? fmax(nearby, 0.02) : nearby) ? 2 + doubles : 1;
            if (other > rank || (other == 1 && rank == 1 && off <= fabs(best - middle) / span)) {
                rank = other;
                best = at;
            }
        }
    }
    if (rank == 0) {
        return 0;
    }
    if (!pbwfill__between(p, q, best * ldexp(1, -PBWFILL__STEPS), x)) {
        pbwfill__rest rest;
        pbwfill__between_exactly(w, p, q, best * ldexp(1, -PBWFILL__STEPS), x, &rest);
        memcpy(rest.ends, piece->ends, sizeof rest.ends);
        x[3] = (double)w->rests.count;
        if (!PBW_PUSH(&w->memory, w->rests, rest)) {
            return PBW_NONE;
        }
    }
    return PBW_PUSH(&w->memory, w->ends_of, piece->ends[0]) && PBW_PUSH(&w->memory, w->ends_of, piece->ends[1])
        && pbwfill__new_vertex(w, x) ? (uint32_t)best : PBW_NONE;
}

/* Splits piece i if it is no edge. */
static pbw_status pbwfill__mend_piece(pbwfill__work *w, pbw_index i, pbwfill__indices *queue)
{
    pbwfill__sight sight;
    pbw_index made;
    const pbwfill__piece piece = w->pieces.at[i];
    const pbw_index vertex = (pbw_index)pbwfill__vertices(w);
    if (!pbwfill__look_along(w, &piece, &sight)) {
        return PBW_OK;
    }
    if (sight.vertex != PBW_NONE && pbwfill__is_on_line(w, pbwfill__at(w, piece.a), pbwfill__at(w, piece.b),
                                                        pbwfill__at(w, sight.vertex))) {
        if (sight.vertex >= w->inputs || piece.from > 0 || piece.to < 1u << PBWFILL__STEPS) {
            return pbwfill__refuse(w, PBW_FILL_CROSSING, PBW_NONE, PBW_NONE);
        }
        made = pbwfill__cut_at_input(w, i, sight.vertex);
    } else {
        double nearby;
        const double want = pbwfill__split_at(w, &piece, &sight, &nearby);
        const uint32_t at = pbwfill__add_split(w, &piece, want, nearby);
        if (at == 0) {
            return pbwfill__refuse(w, PBW_FILL_TOO_FINE, w->edges.at[piece.edge].a, w->edges.at[piece.edge].b);
        }
        made = at == PBW_NONE ? PBW_NONE : pbwfill__cut(w, i, vertex, at);
        w->report->segment_points++;
        if (made != PBW_NONE) {
            const double *p = pbwfill__at(w, vertex);
            if (!pbwfill__open_cavity(w, pbwfill__locate(w, w->at.at[piece.a], p), p)
                || !pbwfill__make_star(w, vertex)) {
                return PBW_ERROR_MEMORY;
            }
        }
        if ((double)w->report->segment_points > (w->how.most > 0 ? (double)w->how.most : 5e7)) {
            return PBW_ERROR_TOO_LARGE;
        }
    }
    return made != PBW_NONE && PBW_PUSH(&w->memory, *queue, i) && PBW_PUSH(&w->memory, *queue, made)
         ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Notes in `noted` which pieces between touched vertices are no edges. */
static pbw_status pbwfill__note_missing(void *arg, size_t from, size_t to)
{
    pbwfill__work *w = (pbwfill__work *)arg;
    size_t i;
    for (i = from; i < to; i++) {
        const pbwfill__piece *p = w->pieces.at + i;
        pbwfill__sight sight;
        w->noted.at[i] = w->touched.at[p->a] && w->touched.at[p->b] && pbwfill__look_along(w, p, &sight);
    }
    return PBW_OK;
}

/* Fills the queue with those pieces, some of each row of neighbours first: points that are put along a row of needles
   one after the other would each change tetrahedra up to its end. */
static pbw_status pbwfill__list_missing(pbwfill__work *w, pbwfill__indices *queue)
{
    pbw_status status = PBW_FIT(&w->memory, w->noted, w->pieces.count) ? PBW_OK : PBW_ERROR_MEMORY;
    size_t i, step;
    status = status != PBW_OK ? status : pbw_for(pbwfill__inner_options(w), w->pieces.count, PBWFILL__GRAIN,
                                                 pbwfill__note_missing, w);
    queue->count = 0;
    for (step = 4096; step > 0; step /= 64) {
        for (i = step / 2; status == PBW_OK && i < w->pieces.count; i += step) {
            status = !w->noted.at[i] || PBW_PUSH(&w->memory, *queue, (pbw_index)i) ? PBW_OK : PBW_ERROR_MEMORY;
            w->noted.at[i] = 0;
        }
    }
    memset(w->touched.at, 0, w->touched.count);
    return status;
}

static pbw_status pbwfill__recover_segments(pbwfill__work *w)
{
    pbwfill__indices queue = { NULL, 0, 0 };
    pbw_status status;
    size_t i, round;
    memset(w->touched.at, 1, w->touched.count);
    status = pbwfill__list_missing(w, &queue);
    w->report->missing_segments = queue.count;
    for (round = 0; status == PBW_OK && queue.count > 0; round++) {
        for (i = 0; status == PBW_OK && i < queue.count; i++) {
            status = pbwfill__tick(w, 1 - 1 / (1 + (double)round)) ? PBW_CANCELLED
                   : pbwfill__mend_piece(w, queue.at[i], &queue);
        }
        status = status != PBW_OK ? status : pbwfill__list_missing(w, &queue);
    }
    PBW_RELEASE(&w->memory, queue);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>cavities     One side of a facet's cavity, wrapped into tetrahedra.
   In: faces, the boundary of a polyhedron but for its floor, which is in a plane; vertices.  Out: `made`, tetrahedra
   that fill it, with links among themselves and in the faces; their faces in the plane.
   The tetrahedron at an open face has the corner of which the sphere holds no other one that could be taken: the
   constrained Delaunay triangulation (Shewchuk 1998, "A condition guaranteeing the existence of higher-dimensional
   constrained Delaunay triangulations"), which is unique under the tie rule.
   ------------------------------------------------------------------------------------------------------ */
/* Whether the segment p-q, both in the triangle's plane and neither a corner, meets the triangle: one of its sides,
   as no vertex is within a triangle; axis: to look along. */
static int pbwfill__meets_in_plane(const pbwfill__work *w, const double *p, const double *q,
                                   const double *const c[3], int axis)
{
    int i, k;
    for (i = 0; i < 3; i++) {
        const double *a = c[i], *b = c[(i + 1) % 3];
        int smaller = 0, larger = 0;                 /* of p and q against a and b */
        if (pbwfill__turn(w, p, q, a, axis) * pbwfill__turn(w, p, q, b, axis) > 0
            || pbwfill__turn(w, a, b, p, axis) * pbwfill__turn(w, a, b, q, axis) > 0) {
            continue;
        }
        for (k = 0; k < 4; k++) {                    /* on one line, too */
            smaller += pbwfill__is_larger(w, k / 2 ? b : a, k % 2 ? q : p);
            larger += pbwfill__is_larger(w, k % 2 ? q : p, k / 2 ? b : a);
        }
        if (smaller < 4 && larger < 4) {
            return 1;
        }
    }
    return 0;
}

/* Whether the edge p-q meets the triangle elsewhere than in a common corner or edge. */
static int pbwfill__meets(const pbwfill__work *w, pbw_index p, pbw_index q, const pbw_index v[3])
{
    const double *a = pbwfill__at(w, p), *b = pbwfill__at(w, q), *c[3];
    int k, first, second, low = 0, high = 0, common = 3;
    for (k = 0; k < 3; k++) {
        c[k] = pbwfill__at(w, v[k]);
        if (v[k] == p || v[k] == q) {
            if (common < 3) {
                return 0;                            /* an edge of the triangle */
            }
            common = k;
        }
    }
    if (common < 3) {
        const double *away = v[common] == p ? b : a, *next = c[(common + 1) % 3], *last = c[(common + 2) % 3];
        int axis, turn;
        if (pbwfill__orient3(w, c[0], c[1], c[2], away) != 0) {
            return 0;
        }
        axis = pbwfill__axis_of(w, c[0], c[1], c[2]);
        turn = pbwfill__turn(w, c[common], next, last, axis);
        return pbwfill__turn(w, c[common], next, away, axis) * turn >= 0
            && pbwfill__turn(w, c[common], away, last, axis) * turn >= 0;
    }
    first = pbwfill__orient3(w, c[0], c[1], c[2], a);
    second = pbwfill__orient3(w, c[0], c[1], c[2], b);
    if (first * second > 0) {
        return 0;
    }
    if (first == 0 && second == 0) {
        return pbwfill__meets_in_plane(w, a, b, c, pbwfill__axis_of(w, c[0], c[1], c[2]));
    }
    for (k = 0; k < 3; k++) {
        const int s = pbwfill__orient3(w, a, b, c[k], c[(k + 1) % 3]);
        low |= s < 0;
        high |= s > 0;
    }
    return !low || !high;
}

/* In `beyond`: bits 0 to 2 and BEHIND are for the faces of a tetrahedron v d, across from v[0] to v[2] and from d:
   the vertex is strictly beyond, or a corner of it. */
enum { PBWFILL__BEHIND = 8, PBWFILL__CANDIDATE = 16 };

/* Whether the tetrahedron of a face and vertex d meets a face of the given side otherwise than the faces of a
   triangulation do.  It does not where all corners of that are beyond one of its faces, or corners of it. */
static int pbwfill__is_blocked(pbwfill__work *w, const pbw_index v[3], pbw_index d, int side)
{
    size_t i;
    int k, j;
    w->ticks += w->faces.count / 8;
    for (i = 0; i < w->list.count; i++) {
        const pbw_index u = w->list.at[i];
        unsigned char *bits = w->beyond.at + u;
        *bits &= PBWFILL__BEHIND | PBWFILL__CANDIDATE;
        if (u == d || u == v[0] || u == v[1] || u == v[2]) {
            *bits = u == d ? 7 : u == v[0] ? 14 : u == v[1] ? 13 : 11;
            continue;
        }
        for (k = 0; k < 3; k++) {
            const int turn = pbwfill__orient(w, k == 0 ? u : v[0], k == 1 ? u : v[1], k == 2 ? u : v[2], d);
            *bits |= (unsigned char)((turn < 0) << k);
        }
    }
    for (i = 0; i < w->faces.count; i++) {
        const pbwfill__face *f = w->faces.at + i;
        const unsigned char *bits = w->beyond.at;
        if (f->side != side || (bits[f->v[0]] & bits[f->v[1]] & bits[f->v[2]] & 15) != 0) {
            continue;
        }
        for (k = 0; k < 3; k++) {
            pbw_index flank[3];
            flank[0] = v[k];
            flank[1] = v[(k + 1) % 3];
            flank[2] = d;
            if (pbwfill__meets(w, v[k], d, f->v)) {
                return 1;
            }
            for (j = 0; j < 3; j++) {
                if (pbwfill__meets(w, f->v[j], f->v[(j + 1) % 3], flank)) {
                    return 1;
                }
            }
        }
    }
    return 0;
}

/* The corner for the tetrahedron at a face, among w->list: of those from which the sphere through the face holds no
   better one, the first that is not blocked; PBW_NONE if there is none. */
static pbw_index pbwfill__choose_corner(pbwfill__work *w, const pbw_index v[3], int side)
{
    pbw_index best;
    size_t i;
    for (i = 0; i < w->list.count; i++) {
        const pbw_index d = w->list.at[i];
        const int turn = pbwfill__orient(w, v[0], v[1], v[2], d);
        w->beyond.at[d] = turn < 0 ? PBWFILL__BEHIND : turn > 0 && w->sign.at[d] * side >= 0 ? PBWFILL__CANDIDATE : 0;
    }
    do {
        best = PBW_NONE;
        for (i = 0; i < w->list.count; i++) {
            const pbw_index d = w->list.at[i];
            if ((w->beyond.at[d] & PBWFILL__CANDIDATE) == 0) {
                continue;
            }
            if (best == PBW_NONE
                || pbwfill__conflict3(w, pbwfill__at(w, v[0]), pbwfill__at(w, v[1]), pbwfill__at(w, v[2]),
                                      pbwfill__at(w, best), pbwfill__at(w, d))) {
                best = d;
            }
        }
    } while (best != PBW_NONE && pbwfill__is_blocked(w, v, best, side));
    return best;
}

/* Returns the slot of an oriented face: its least id first. */
static pbw_index *pbwfill__put_turned(pbwfill__work *w, const pbw_index v[3])
{
    const int k = v[0] < v[1] && v[0] < v[2] ? 0 : v[1] < v[2] ? 1 : 2;
    return pbwfill__put(w, &w->table, v[k], v[(k + 1) % 3], v[(k + 2) % 3]);
}

/* Values of the table of open faces: a face of the boundary, 4 tets + corner of one between tetrahedra, or CLOSED. */
#define PBWFILL__CLOSED 0xfffffffeu
#define PBWFILL__BOUNDARY 0x80000000u

/* Adds the tetrahedron of a face and vertex d; its faces close open ones, or become open.  floor: gets faces with all
   corners in the plane. */
static pbw_status pbwfill__add_tet(pbwfill__work *w, const pbw_index v[3], pbw_index d, pbwfill__indices *open,
                                   pbwfill__indices *floor)
{
    const pbw_index made = (pbw_index)w->made.count;
    pbwfill__tet tet;
    unsigned i, k;
    memset(&tet, 0xff, sizeof tet);                  /* PBW_NONE */
    memcpy(tet.v, v, 3 * sizeof *v);
    tet.v[3] = d;
    if (!PBW_PUSH(&w->memory, w->made, tet)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < 4; i++) {
        pbw_index face[3], *slot;
        for (k = 0; k < 3; k++) {                    /* seen from the tetrahedron, as those that it closes */
            face[k] = tet.v[PBW_FACET_CORNER(i, 2 - k)];
        }
        if (w->sign.at[face[0]] == 0 && w->sign.at[face[1]] == 0 && w->sign.at[face[2]] == 0) {
            if (!PBW_PUSH(&w->memory, *floor, 4 * made + i)) {
                return PBW_ERROR_MEMORY;
            }
            continue;
        }
        slot = pbwfill__put_turned(w, face);
        if (slot == NULL) {
            return PBW_ERROR_MEMORY;
        }
        if (*slot == PBWFILL__CLOSED) {
            return PBW_DEGENERATE;                   /* a second tetrahedron at one face */
        }
        if (*slot == PBW_NONE) {
            *slot = PBWFILL__CLOSED;                 /* its other side is open now */
            k = face[0], face[0] = face[1], face[1] = k;
            slot = pbwfill__put_turned(w, face);
            if (slot == NULL || !PBW_RESERVE(&w->memory, *open, 3)) {
                return PBW_ERROR_MEMORY;
            }
            if (*slot != PBW_NONE) {
                return PBW_DEGENERATE;
            }
            *slot = 4 * made + i;
            memcpy(open->at + open->count, face, sizeof face);
            open->count += 3;
        } else {
            if (*slot >= PBWFILL__BOUNDARY) {
                pbwfill__face *f = w->faces.at + (*slot - PBWFILL__BOUNDARY);
                f->tet = made;
                f->corner = i;
            } else {
                w->made.at[made].n[i] = *slot;
                w->made.at[*slot / 4].n[*slot % 4] = 4 * made + i;
            }
            *slot = PBWFILL__CLOSED;
        }
    }
    return PBW_OK;
}

/* Opens the faces of a side.  Returns 0 without memory. */
static int pbwfill__open_faces(pbwfill__work *w, int side, pbwfill__indices *open)
{
    size_t i;
    pbwfill__clear(&w->table);
    for (i = 0; i < w->faces.count; i++) {
        const pbwfill__face *f = w->faces.at + i;
        if (f->side == side) {
            pbw_index *slot = pbwfill__put_turned(w, f->v);
            if (slot == NULL || !PBW_RESERVE(&w->memory, *open, 3)) {
                return 0;
            }
            *slot = PBWFILL__BOUNDARY + (pbw_index)i;
            memcpy(open->at + open->count, f->v, sizeof f->v);
            open->count += 3;
        }
    }
    return 1;
}

/* Fills one side of the cavity, until `most` tetrahedra are made in all.  Returns PBW_DEGENERATE if it cannot. */
static pbw_status pbwfill__wrap(pbwfill__work *w, int side, size_t most, pbwfill__indices *floor)
{
    pbwfill__indices open = { NULL, 0, 0 };
    pbw_status status = pbwfill__open_faces(w, side, &open) ? PBW_OK : PBW_ERROR_MEMORY;
    while (status == PBW_OK && open.count > 0) {
        pbw_index v[3], corner;
        open.count -= 3;
        memcpy(v, open.at + open.count, sizeof v);
        if (*pbwfill__put_turned(w, v) == PBWFILL__CLOSED) {         /* it is there, so nothing is allocated */
            continue;
        }
        corner = w->made.count < most ? pbwfill__choose_corner(w, v, side) : PBW_NONE;
        status = pbwfill__tick(w, 0) ? PBW_CANCELLED : corner == PBW_NONE ? PBW_DEGENERATE
               : pbwfill__add_tet(w, v, corner, &open, floor);
    }
    PBW_RELEASE(&w->memory, open);
    return status;
}

/* Joins all faces of a side to one vertex, which sees them, but those that have it. */
static pbw_status pbwfill__join(pbwfill__work *w, int side, pbw_index vertex)
{
    pbwfill__indices open = { NULL, 0, 0 }, floor = { NULL, 0, 0 };
    pbw_status status = pbwfill__open_faces(w, side, &open) ? PBW_OK : PBW_ERROR_MEMORY;
    size_t i;
    for (i = 0; i < w->faces.count && status == PBW_OK; i++) {
        const pbwfill__face *f = w->faces.at + i;
        if (f->side == side && f->v[0] != vertex && f->v[1] != vertex && f->v[2] != vertex) {
            status = pbwfill__add_tet(w, f->v, vertex, &open, &floor);
        }
    }
    for (i = 0; i < open.count && status == PBW_OK; i += 3) {
        status = *pbwfill__put_turned(w, open.at + i) == PBWFILL__CLOSED ? PBW_OK : PBW_DEGENERATE;
    }
    PBW_RELEASE(&w->memory, open);
    PBW_RELEASE(&w->memory, floor);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>facets       Each facet found in the triangulation, or made there.
   In: a triangulation in which all pieces of segments are edges.  Out: the constrained Delaunay triangulation, with
   the facets in `wall`.
   A facet is walked over from its border: at each edge, the half-plane of the facet either is a face of the
   triangulation or passes between two corners.  Then the tetrahedra that the plane cuts are replaced, on both sides.
   ------------------------------------------------------------------------------------------------------ */
/* Of the ends i and j of an edge and the others k and l of a tetrahedron, k: i j k l is an even permutation. */
static const unsigned char pbwfill__third[4][4] = { { 4, 2, 3, 1 }, { 3, 4, 0, 2 }, { 1, 3, 4, 0 }, { 2, 0, 1, 4 } };

typedef struct pbwfill__plane { pbw_index v[3], facet; } pbwfill__plane;

/* The side of the facet's plane that v is on, which is remembered. */
static int pbwfill__side_of(pbwfill__work *w, const pbwfill__plane *plane, pbw_index v)
{
    if (w->seen_vertex.at[v] != plane->facet + 1) {
        w->seen_vertex.at[v] = plane->facet + 1;
        w->sign.at[v] = (signed char)pbwfill__orient(w, plane->v[0], plane->v[1], plane->v[2], v);
    }
    return w->sign.at[v];
}

/* Returns a tetrahedron with both vertices, of the star of u; PBW_NONE if they have no edge or memory is short. */
static pbw_index pbwfill__with_edge(pbwfill__work *w, pbw_index u, pbw_index v)
{
    size_t i;
    unsigned k;
    w->epoch += 2;
    w->list.count = 0;
    w->seen.at[w->at.at[u]] = w->epoch;
    w->starved = !PBW_PUSH(&w->memory, w->list, w->at.at[u]);
    for (i = 0; i < w->list.count && !w->starved; i++) {
        const pbwfill__tet *t = w->tets.at + w->list.at[i];
        if (pbwfill__corner_of(t, v) < 4) {
            return w->list.at[i];
        }
        for (k = 0; k < 4; k++) {
            if (t->v[k] != u && t->n[k] != PBW_NONE && w->seen.at[t->n[k]] != w->epoch) {
                w->seen.at[t->n[k]] = w->epoch;
                w->starved |= !PBW_PUSH(&w->memory, w->list, t->n[k]);
            }
        }
    }
    return PBW_NONE;
}

/* What the facet's half-plane to the left of u-v, seen from above, is: the face of tetrahedron *t across from corner
   *corner, returns 1; or it cuts *t, returns 0; -1: there is no such edge. */
static int pbwfill__look_left(pbwfill__work *w, const pbwfill__plane *plane, pbw_index u, pbw_index v, pbw_index *t,
                              unsigned *corner)
{
    const pbw_index start = *t;
    do {
        const pbwfill__tet *tet = w->tets.at + *t;
        const unsigned i = pbwfill__corner_of(tet, u), j = pbwfill__corner_of(tet, v);
        const unsigned k = pbwfill__third[i][j], l = 6 - i - j - k;
        const int c = pbwfill__side_of(w, plane, tet->v[k]), d = pbwfill__side_of(w, plane, tet->v[l]);
        if (c < 0 && d > 0) {
            return 0;
        }
        if ((c < 0 && d == 0) || (c == 0 && d > 0)) {
            *corner = d == 0 ? k : l;
            return 1;
        }
        *t = tet->n[k];                              /* across the face with l */
    } while (*t != start && *t != PBW_NONE);
    return -1;
}

/* Lists the tetrahedra that the plane cuts, from t: across faces with corners on both sides. */
static pbw_status pbwfill__find_cut(pbwfill__work *w, const pbwfill__plane *plane, pbw_index t)
{
    size_t i;
    unsigned k, j;
    w->epoch += 2;
    w->cavity.count = 0;
    w->seen.at[t] = w->epoch;
    if (!PBW_PUSH(&w->memory, w->cavity, t)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < w->cavity.count; i++) {
        const pbwfill__tet tet = w->tets.at[w->cavity.at[i]];
        if (pbwfill__tick(w, 0)) {
            return PBW_CANCELLED;
        }
        for (k = 0; k < 4; k++) {
            int above = 0, below = 0;
            for (j = 0; j < 3; j++) {
                const pbw_index u = tet.v[PBW_FACET_CORNER(k, j)], v = tet.v[PBW_FACET_CORNER(k, (j + 1) % 3)];
                const int s = pbwfill__side_of(w, plane, u);
                above |= s > 0;
                below |= s < 0;
                if (s * pbwfill__side_of(w, plane, v) < 0 && pbwfill__is_wire(w, u, v)) {
                    return pbwfill__refuse(w, PBW_FILL_CROSSING, w->members.at[
                                           w->facet_first.at[plane->facet]], PBW_NONE);
                }
            }
            if (!above || !below || tet.n[k] == PBW_NONE) {
                continue;
            }
            if (tet.wall[k] != PBW_NONE) {
                return pbwfill__refuse(w, PBW_FILL_CROSSING, w->members.at[w->facet_first.at[plane->facet]],
                                       w->members.at[w->facet_first.at[tet.wall[k]]]);
            }
            if (w->seen.at[tet.n[k]] != w->epoch) {
                w->seen.at[tet.n[k]] = w->epoch;
                if (!PBW_PUSH(&w->memory, w->cavity, tet.n[k])) {
                    return PBW_ERROR_MEMORY;
                }
            }
        }
    }
    return PBW_OK;
}

/* Lists the faces and the vertices of the cavity. */
static int pbwfill__list_faces(pbwfill__work *w)
{
    size_t i;
    unsigned k, j;
    w->faces.count = w->list.count = 0;
    pbwfill__clear(&w->table);
    for (i = 0; i < w->cavity.count; i++) {
        const pbw_index t = w->cavity.at[i];
        const pbwfill__tet *tet = w->tets.at + t;
        for (k = 0; k < 4; k++) {
            const int inner = tet->n[k] != PBW_NONE && w->seen.at[tet->n[k]] == w->epoch;
            pbw_index *vertex = pbwfill__put(w, &w->table, tet->v[k], PBW_NONE, PBW_NONE);
            pbwfill__face f;
            if (vertex == NULL || (*vertex == PBW_NONE && !PBW_PUSH(&w->memory, w->list, tet->v[k]))) {
                return 0;
            }
            *vertex = 0;
            if (inner && tet->wall[k] == PBW_NONE) {
                continue;
            }
            memset(&f, 0, sizeof f);
            f.outside = inner ? PBW_NONE : tet->n[k];
            f.wall = tet->wall[k];
            f.tet = PBW_NONE;
            for (j = 0; j < 3; j++) {
                f.v[j] = tet->v[PBW_FACET_CORNER(k, 2 - j)];
                f.side = w->sign.at[f.v[j]] != 0 ? w->sign.at[f.v[j]] : f.side;
            }
            f.back = f.outside == PBW_NONE ? 0 : pbwfill__across(w->tets.at + f.outside, f.v);
            if (!PBW_PUSH(&w->memory, w->faces, f)) {
                return 0;
            }
        }
    }
    return 1;
}

/* Links corner i of the new tetrahedron t to the one that is there under the key of the face, or puts it there. */
static int pbwfill__pair_up(pbwfill__work *w, pbw_index t, unsigned i)
{
    const pbwfill__tet *tet = w->tets.at + t;
    pbw_index *other = pbwfill__put_sorted(w, &w->table, tet->v[PBW_FACET_CORNER(i, 0)],
                                           tet->v[PBW_FACET_CORNER(i, 1)], tet->v[PBW_FACET_CORNER(i, 2)]);
    if (other == NULL) {
        return 0;
    }
    if (*other == PBW_NONE) {
        *other = 4 * t + i;
    } else {
        pbwfill__link(w, t, i, *other / 4, *other % 4);
    }
    return 1;
}

/* Puts the tetrahedra made in the place of the cavity; floor: their faces on the facet, those above first. */
static pbw_status pbwfill__replace(pbwfill__work *w, pbw_index facet, const pbwfill__indices *floor)
{
    size_t i;
    unsigned k;
    pbwfill__indices places = { NULL, 0, 0 };
    int good = pbwfill__reserve(w, w->made.count) && PBW_ZEROS(&w->memory, places, w->made.count)
            && PBW_RESERVE(&w->memory, w->unused, w->cavity.count);
    for (i = 0; good && i < w->made.count; i++) {
        places.at[i] = pbwfill__new_tet(w);
        if (w->region.count > 0) {
            good = pbwfill__set_region(w, places.at[i], w->made_region.count > 0 ? w->made_region.at[i]
                                       : w->region.at[w->cavity.at[0]]);
        }
    }
    for (i = 0; good && i < w->made.count; i++) {
        pbwfill__tet *t = w->tets.at + places.at[i];
        *t = w->made.at[i];
        for (k = 0; k < 4; k++) {
            t->n[k] = t->n[k] == PBW_NONE ? PBW_NONE : places.at[t->n[k] / 4];
            w->at.at[t->v[k]] = places.at[i];
            w->touched.at[t->v[k]] = 1;
        }
    }
    pbwfill__clear(&w->table);
    for (i = 0; good && i < w->faces.count; i++) {
        const pbwfill__face *f = w->faces.at + i;
        const pbw_index t = places.at[f->tet];
        w->tets.at[t].wall[f->corner] = f->wall;
        w->faces.at[i].tet = t;
        if (f->outside != PBW_NONE) {
            pbwfill__link(w, t, f->corner, f->outside, f->back);
        } else {                                     /* of a face with the cavity on both sides */
            good = pbwfill__pair_up(w, t, f->corner);
        }
    }
    for (i = 0; good && i < floor->count; i++) {
        const pbw_index t = places.at[floor->at[i] / 4];
        w->tets.at[t].wall[floor->at[i] % 4] = facet;
        good = pbwfill__pair_up(w, t, floor->at[i] % 4);
    }
    for (i = 0; good && i < w->cavity.count; i++) {
        good = pbwfill__drop_tet(w, w->cavity.at[i]);
    }
    PBW_RELEASE(&w->memory, places);
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Whether the faces above and below are the same. */
static int pbwfill__floors_agree(pbwfill__work *w, const pbwfill__indices *floor, size_t above)
{
    size_t i;
    w->starved = 0;
    if (floor->count != 2 * above) {
        return 0;
    }
    pbwfill__clear(&w->table);
    for (i = 0; i < floor->count; i++) {
        const pbwfill__tet *t = w->made.at + floor->at[i] / 4;
        const unsigned k = floor->at[i] % 4;
        pbw_index *slot = pbwfill__put_sorted(w, &w->table, t->v[PBW_FACET_CORNER(k, 0)],
                                              t->v[PBW_FACET_CORNER(k, 1)], t->v[PBW_FACET_CORNER(k, 2)]);
        w->starved = slot == NULL;
        if (w->starved || (i < above) != (*slot == PBW_NONE)) {
            return 0;
        }
        *slot = 0;
    }
    return 1;
}

/* Replaces the tetrahedra that the plane cuts, from t on, by others that have the facet's faces. */
static pbw_status pbwfill__fill_cut(pbwfill__work *w, const pbwfill__plane *plane, pbw_index t)
{
    pbwfill__indices floor = { NULL, 0, 0 };
    pbw_status status = pbwfill__find_cut(w, plane, t);
    size_t above = 0, most;
    if (status == PBW_OK && !pbwfill__list_faces(w)) {
        status = PBW_ERROR_MEMORY;
    }
    w->made.count = 0;
    most = w->list.count * w->list.count + 100;      /* more than any triangulation of them has */
    status = status != PBW_OK ? status : pbwfill__wrap(w, 1, most, &floor);
    above = floor.count;
    status = status != PBW_OK ? status : pbwfill__wrap(w, -1, most, &floor);
    if (status == PBW_OK && !pbwfill__floors_agree(w, &floor, above)) {
        status = w->starved ? PBW_ERROR_MEMORY : PBW_DEGENERATE;
    }
    status = status != PBW_OK ? status : pbwfill__replace(w, plane->facet, &floor);
    PBW_RELEASE(&w->memory, floor);
    if (status == PBW_DEGENERATE && w->report->refusal == PBW_FILL_FILLED) {
        return pbwfill__refuse(w, PBW_FILL_CROSSING, w->members.at[w->facet_first.at[plane->facet]], PBW_NONE);
    }
    return status;
}

typedef struct pbwfill__side { pbw_index u, v, tet; } pbwfill__side;     /* the facet is to the left of u-v */
typedef PBW_ARRAY(pbwfill__side) pbwfill__walk;

/* Adds side u-v to the border of the facet, and to what is to be looked at. */
static int pbwfill__add_border(pbwfill__work *w, pbwfill__walk *walk, pbw_index u, pbw_index v)
{
    pbwfill__side side;
    pbw_index *border = pbwfill__put(w, &w->borders, u, v, PBW_NONE);
    side.u = u;
    side.v = v;
    side.tet = PBW_NONE;
    return border != NULL && (*border = 0, PBW_PUSH(&w->memory, *walk, side) != 0);
}

/* Lists the pieces at the border of the facet.  Returns 0 without memory, or if the caller cancels. */
static int pbwfill__list_border(pbwfill__work *w, const pbwfill__plane *plane, pbwfill__walk *walk)
{
    const double *p[3];
    int axis, turn, k;
    size_t i;
    for (k = 0; k < 3; k++) {
        p[k] = pbwfill__at(w, plane->v[k]);
    }
    axis = pbwfill__axis_of(w, p[0], p[1], p[2]);
    turn = pbwfill__turn(w, p[0], p[1], p[2], axis);
    pbwfill__clear(&w->borders);
    pbwfill__clear(&w->covered);
    for (i = w->facet_first.at[plane->facet]; i < w->facet_first.at[plane->facet + 1]; i++) {
        const size_t t = 3 * (size_t)w->members.at[i];
        const pbw_index *c = w->corners.at + t;
        const int same = turn == pbwfill__turn(w, pbwfill__at(w, c[0]), pbwfill__at(w, c[1]), pbwfill__at(w, c[2]),
                                               axis);
        if (pbwfill__tick(w, 0)) {
            return 0;
        }
        for (k = 0; k < 3; k++) {
            const pbwfill__edge *e = w->edges.at + w->edge_of.at[t + (size_t)k];
            const pbw_index from = c[(k + (same ? 1 : 2)) % 3];
            pbw_index piece;
            for (piece = e->piece; piece != PBW_NONE; piece = w->pieces.at[piece].next) {
                const pbwfill__piece *s = w->pieces.at + piece;
                if (!pbwfill__add_border(w, walk, from == e->a ? s->a : s->b, from == e->a ? s->b : s->a)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Marks the face to the left of a side, in its tetrahedron across from a corner, as the facet's, on both sides;
   queues what is beyond the face's edges. */
static int pbwfill__take_face(pbwfill__work *w, const pbwfill__plane *plane, const pbwfill__side *side,
                              unsigned corner, pbwfill__walk *walk)
{
    pbwfill__tet *tet = w->tets.at + side->tet;
    const pbw_index next = tet->n[corner];
    const unsigned i = pbwfill__corner_of(tet, side->u), j = pbwfill__corner_of(tet, side->v);
    pbw_index v[3];
    int k;
    v[0] = side->u;
    v[1] = side->v;
    v[2] = tet->v[6 - i - j - corner];
    tet->wall[corner] = plane->facet;
    w->tets.at[next].wall[pbwfill__back(w->tets.at + next, side->tet)] = plane->facet;
    for (k = 0; k < 3; k++) {
        const pbw_index a = v[k], b = v[(k + 1) % 3];
        pbwfill__side beyond;
        pbw_index *covered = pbwfill__put(w, &w->covered, a, b, PBW_NONE);
        if (covered == NULL) {
            return 0;
        }
        *covered = 0;
        beyond.u = b;
        beyond.v = a;
        beyond.tet = side->tet;
        if (pbwfill__look_up(&w->borders, a, b, PBW_NONE) == PBW_NONE
            && pbwfill__look_up(&w->covered, b, a, PBW_NONE) == PBW_NONE && !PBW_PUSH(&w->memory, *walk, beyond)) {
            return 0;
        }
    }
    return 1;
}

/* Makes all faces of a facet; *missing: some were not there. */
static pbw_status pbwfill__recover_facet(pbwfill__work *w, pbw_index facet, pbwfill__walk *walk, int *missing)
{
    const pbw_index *c = w->corners.at + 3 * (size_t)w->members.at[w->facet_first.at[facet]];
    pbwfill__plane plane;
    memcpy(plane.v, c, sizeof plane.v);
    plane.facet = facet;
    walk->count = 0;
    if (!pbwfill__list_border(w, &plane, walk)) {
        return PBW_ERROR_MEMORY;
    }
    while (walk->count > 0) {
        pbwfill__side side = walk->at[--walk->count];
        unsigned corner = 0;
        int found = 0;
        if (pbwfill__tick(w, 0)) {
            return PBW_CANCELLED;
        }
        if (pbwfill__look_up(&w->covered, side.u, side.v, PBW_NONE) != PBW_NONE) {
            continue;
        }
        if (side.tet == PBW_NONE || pbwfill__corner_of(w->tets.at + side.tet, side.u) == 4
            || pbwfill__corner_of(w->tets.at + side.tet, side.v) == 4 || w->tets.at[side.tet].v[0] == PBW_NONE) {
            side.tet = pbwfill__with_edge(w, side.u, side.v);
        }
        found = side.tet == PBW_NONE ? -1 : pbwfill__look_left(w, &plane, side.u, side.v, &side.tet, &corner);
        if (found < 0 && w->starved) {
            return PBW_ERROR_MEMORY;
        }
        if (found < 0) {
            return pbwfill__refuse(w, PBW_FILL_CROSSING, w->members.at[w->facet_first.at[facet]], PBW_NONE);
        }
        if (found == 0) {
            const pbw_status status = pbwfill__fill_cut(w, &plane, side.tet);
            *missing = 1;
            side.tet = PBW_NONE;
            if (status != PBW_OK) {
                return status;
            }
            if (!PBW_PUSH(&w->memory, *walk, side)) {
                return PBW_ERROR_MEMORY;
            }
        } else if (!pbwfill__take_face(w, &plane, &side, corner, walk)) {
            return PBW_ERROR_MEMORY;
        }
    }
    return PBW_OK;
}

/* Finds a triangle with edges of one piece each among the faces of the Delaunay triangulation.  Returns 4 times a
   tetrahedron plus the corner across, PBW_NONE if there is none. */
static pbw_index pbwfill__find_face(const pbwfill__work *w, size_t triangle)
{
    const pbw_index *c = w->corners.at + 3 * triangle;
    pbw_index start, t;
    int k;
    for (k = 0; k < 3; k++) {
        if (w->pieces.at[w->edges.at[w->edge_of.at[3 * triangle + (size_t)k]].piece].next != PBW_NONE) {
            return PBW_NONE;
        }
    }
    t = start = pbwfill__toward(w, c[0], c[1]);
    do {                                             /* around the edge */
        const pbwfill__tet *tet = w->tets.at + t;
        const unsigned i = pbwfill__corner_of(tet, c[0]), j = pbwfill__corner_of(tet, c[1]);
        const unsigned l = pbwfill__third[i][j], m = 6 - i - j - l;
        if (tet->v[l] == c[2]) {
            return 4 * t + m;
        }
        t = tet->n[l];
    } while (t != start && t != PBW_NONE);
    return PBW_NONE;
}

/* Marks the faces of triangles that are there already, and in `noted` their facets.  No two threads write to one
   place, as no face is that of two triangles. */
static pbw_status pbwfill__mark_faces(void *arg, size_t from, size_t to)
{
    pbwfill__work *w = (pbwfill__work *)arg;
    size_t i;
    for (i = from; i < to; i++) {
        const size_t first = w->facet_first.at[i];
        const pbw_index face = w->facet_first.at[i + 1] > first + 1 ? PBW_NONE
                             : pbwfill__find_face(w, w->members.at[first]);
        w->noted.at[i] = face != PBW_NONE;
        if (face != PBW_NONE) {
            const pbw_index next = w->tets.at[face / 4].n[face % 4];
            w->tets.at[face / 4].wall[face % 4] = (pbw_index)i;
            w->tets.at[next].wall[pbwfill__back(w->tets.at + next, face / 4)] = (pbw_index)i;
        }
    }
    return PBW_OK;
}

static pbw_status pbwfill__recover_facets(pbwfill__work *w)
{
    pbwfill__walk walk = { NULL, 0, 0 };
    pbw_status status = PBW_FIT(&w->memory, w->noted, w->report->facets) ? PBW_OK : PBW_ERROR_MEMORY;
    size_t i;
    memset(w->seen_vertex.at, 0, w->seen_vertex.count * sizeof *w->seen_vertex.at);
    status = status != PBW_OK ? status : pbw_for(pbwfill__inner_options(w), w->report->facets, PBWFILL__GRAIN,
                                                 pbwfill__mark_faces, w);
    for (i = 0; i < w->pieces.count && status == PBW_OK; i++) {
        const pbwfill__piece *p = w->pieces.at + i;
        if (w->edges.at[p->edge].count == 0) {
            pbw_index *wire = pbwfill__put(w, &w->wires, p->a < p->b ? p->a : p->b, p->a < p->b ? p->b : p->a,
                                           PBW_NONE);
            status = wire == NULL ? PBW_ERROR_MEMORY : PBW_OK;
            if (wire != NULL) {
                *wire = 0;
            }
        }
    }
    for (i = 0; i < w->report->facets && status == PBW_OK; i++) {
        int missing = 0;
        status = pbwfill__tick(w, (double)i / (double)w->report->facets) ? PBW_CANCELLED
               : w->noted.at[i] ? PBW_OK : pbwfill__recover_facet(w, (pbw_index)i, &walk, &missing);
        w->report->missing_facets += (size_t)missing;
    }
    PBW_RELEASE(&w->memory, walk);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>regions      What the facets enclose.
   In: the constrained triangulation.  Out: a region of each tetrahedron, PBW_NONE: not kept.
   Holds: a component is what faces that are no walls connect; a body is what edges connect of the surface.  Of the
   components at a body one lies around it, and is reached first from outside; the others are one deeper than that.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwfill__component { pbw_index heads, depth, seed; uint64_t key; } pbwfill__component;
typedef struct pbwfill__contact { pbw_index body, other, next; } pbwfill__contact;   /* of a component: what is beyond
                                                                                        a face, and the body there */
typedef struct pbwfill__map {
    PBW_ARRAY(pbwfill__component) components;        /* the first is outside */
    PBW_ARRAY(pbwfill__contact) contacts;
    pbwfill__indices body;                           /* of each triangle */
    pbwfill__indices around;                         /* of each body: the component around it */
} pbwfill__map;

/* Numbers components in w->region, the one of tetrahedron `first` first. */
static pbw_status pbwfill__find_components(pbwfill__work *w, pbwfill__map *map, pbw_index first)
{
    size_t i;
    w->list.count = 0;
    if (!PBW_FIT(&w->memory, w->region, w->tets.count)) {
        return PBW_ERROR_MEMORY;
    }
    w->region.count = w->tets.count;
    memset(w->region.at, 0xff, w->tets.count * sizeof *w->region.at);         /* PBW_NONE */
    for (i = 0; i <= w->tets.count; i++) {
        const pbw_index start = i == 0 ? first : (pbw_index)(i - 1), number = (pbw_index)map->components.count;
        pbwfill__component c;
        if (w->tets.at[start].v[0] == PBW_NONE || w->region.at[start] != PBW_NONE) {
            continue;
        }
        c.heads = c.depth = c.seed = PBW_NONE;
        c.key = UINT64_MAX;
        w->region.at[start] = number;
        if (!PBW_PUSH(&w->memory, map->components, c) || !PBW_PUSH(&w->memory, w->list, start)) {
            return PBW_ERROR_MEMORY;
        }
        while (w->list.count > 0) {
            const pbwfill__tet *t = w->tets.at + w->list.at[--w->list.count];
            int k;
            if (pbwfill__tick(w, 0)) {
                return PBW_CANCELLED;
            }
            for (k = 0; k < 4; k++) {
                if (t->n[k] != PBW_NONE && t->wall[k] == PBW_NONE && w->region.at[t->n[k]] == PBW_NONE) {
                    w->region.at[t->n[k]] = number;
                    if (!PBW_PUSH(&w->memory, w->list, t->n[k])) {
                        return PBW_ERROR_MEMORY;
                    }
                }
            }
        }
    }
    return PBW_OK;
}

/* Joins triangles over edges to bodies, and lists the contacts of components. */
static pbw_status pbwfill__find_contacts(pbwfill__work *w, pbwfill__map *map)
{
    const size_t triangles = w->corners.count / 3;
    size_t i, j;
    unsigned k;
    if (!PBW_ZEROS(&w->memory, map->body, triangles + 1) || !PBW_FIT(&w->memory, map->around, triangles + 1)) {
        return PBW_ERROR_MEMORY;
    }
    memset(map->around.at, 0xff, (triangles + 1) * sizeof *map->around.at);    /* PBW_NONE */
    for (i = 0; i < triangles; i++) {
        map->body.at[i] = (pbw_index)i;
    }
    for (i = 0; i < w->edges.count; i++) {
        for (j = 1; j < w->edges.at[i].count; j++) {
            const pbw_index *side = w->sides.at + w->edges.at[i].first;
            const pbw_index p = pbwfill__root(map->body.at, side[0] / 3);
            const pbw_index q = pbwfill__root(map->body.at, side[j] / 3);
            map->body.at[p < q ? q : p] = p < q ? p : q;
        }
    }
    for (i = 0; i < w->tets.count; i++) {
        const pbwfill__tet *t = w->tets.at + i;
        if (pbwfill__tick(w, 0)) {
            return PBW_CANCELLED;
        }
        for (k = 0; t->v[0] != PBW_NONE && k < 4; k++) {
            pbwfill__component *c = map->components.at + w->region.at[i];
            pbwfill__contact contact;
            pbw_index member;
            uint64_t key;
            if (t->wall[k] == PBW_NONE) {
                continue;
            }
            member = w->members.at[w->facet_first.at[t->wall[k]]];
            contact.body = pbwfill__root(map->body.at, member);
            contact.other = w->region.at[t->n[k]];
            contact.next = c->heads;
            c->heads = (pbw_index)map->contacts.count;
            key = 2 * (uint64_t)member;
            if (key <= c->key) {
                const pbw_index *v = w->corners.at + 3 * (size_t)member;
                key += pbwfill__orient(w, v[0], v[1], v[2], t->v[k]) > 0;
                c->key = key < c->key ? key : c->key;
            }
            if (!PBW_PUSH(&w->memory, map->contacts, contact)) {
                return PBW_ERROR_MEMORY;
            }
        }
    }
    return PBW_OK;
}

/* Finds how deep each component is, from outside inward. */
static pbw_status pbwfill__find_depths(pbwfill__work *w, pbwfill__map *map)
{
    size_t i;
    w->list.count = 0;
    map->components.at[0].depth = 0;
    if (!PBW_PUSH(&w->memory, w->list, 0)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < w->list.count; i++) {
        const pbw_index c = w->list.at[i];
        pbw_index at;
        for (at = map->components.at[c].heads; at != PBW_NONE; at = map->contacts.at[at].next) {
            const pbwfill__contact *contact = map->contacts.at + at;
            pbw_index *around = map->around.at + contact->body;
            pbwfill__component *other = map->components.at + contact->other;
            *around = *around == PBW_NONE ? c : *around;
            if (other->depth == PBW_NONE) {
                other->depth = map->components.at[c].depth + (*around == c);
                if (!PBW_PUSH(&w->memory, w->list, contact->other)) {
                    return PBW_ERROR_MEMORY;
                }
            }
        }
    }
    return PBW_OK;
}

/* Finds the components of seeds. */
static pbw_status pbwfill__take_seeds(pbwfill__work *w, pbwfill__map *map)
{
    size_t i, k;
    for (i = 0; i < w->input->seed_count; i++) {
        const double *low = pbwfill__at(w, (pbw_index)w->inputs), *high = pbwfill__at(w, (pbw_index)w->inputs + 7);
        const int hole = w->input->seed_regions != NULL && w->input->seed_regions[i] == PBW_NONE;
        double p[PBWFILL__PLACE] = { 0, 0, 0, 0 };
        int inside = 1;
        unsigned j;
        for (k = 0; k < 3; k++) {
            p[k] = pbwfill__scaled(w->input->seeds[3 * i + k], -w->exponent);
            inside &= p[k] >= low[k] && p[k] <= high[k];
        }
        pbwfill__round(w, p);                        /* signs with rests need the range */
        if (!inside && !hole) {
            return pbwfill__refuse(w, PBW_FILL_SEED, (pbw_index)i, PBW_NONE);
        } else if (inside) {
            const pbw_index t = pbwfill__locate(w, w->at.at[w->inputs], p);
            pbw_index *seed = &map->components.at[w->region.at[t]].seed;
            if (w->region.at[t] == 0 && !hole && !w->how.outside) {
                return pbwfill__refuse(w, PBW_FILL_SEED, (pbw_index)i, PBW_NONE);
            }
            for (j = 0; j < 4; j++) {
                const pbwfill__tet *tet = w->tets.at + t;
                const double *a = pbwfill__at(w, tet->v[PBW_FACET_CORNER(j, 0)]);
                const double *b = pbwfill__at(w, tet->v[PBW_FACET_CORNER(j, 1)]);
                if (tet->wall[j] != PBW_NONE
                    && pbwfill__orient3(w, a, b, pbwfill__at(w, tet->v[PBW_FACET_CORNER(j, 2)]), p) == 0) {
                    return pbwfill__refuse(w, PBW_FILL_SEED, (pbw_index)i, PBW_NONE);
                }
            }
            if (*seed != PBW_NONE && w->input->seed_regions != NULL
                && w->input->seed_regions[*seed] != w->input->seed_regions[i]) {
                return pbwfill__refuse(w, PBW_FILL_SEED, (pbw_index)i, *seed);
            }
            *seed = *seed == PBW_NONE ? (pbw_index)i : *seed;
        }
    }
    return PBW_OK;
}

/* Decides which components are kept, and numbers them: seeds say so; others, in the order of their first triangles,
   get the numbers behind those of the seeds; the outside comes last. */
static pbw_status pbwfill__number_regions(pbwfill__work *w, pbwfill__map *map, pbwfill__indices *number)
{
    const size_t count = map->components.count;
    PBW_ARRAY(uint64_t) keys = { NULL, 0, 0 };
    pbwfill__indices order = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    pbw_index next = 0;
    size_t i;
    if (PBW_FIT(&w->memory, keys, count) && PBW_FIT(&w->memory, order, count)
        && PBW_ZEROS(&w->memory, *number, count)) {
        for (i = 0; i < count; i++) {
            keys.at[i] = i == 0 ? UINT64_MAX : map->components.at[i].key;
        }
        status = pbw_sort(keys.at, count, pbwfill__inner_options(w), order.at);
    }
    for (i = 0; status == PBW_OK && i < w->input->seed_count && w->input->seed_regions != NULL; i++) {
        const pbw_index region = w->input->seed_regions[i];
        next = region != PBW_NONE && region >= next ? region + 1 : next;
    }
    for (i = 0; status == PBW_OK && i < count; i++) {
        const pbwfill__component *c = map->components.at + order.at[i];
        const int kept = order.at[i] == 0 ? w->how.outside : w->how.nested || c->depth % 2 == 1 || w->how.outside;
        pbw_index *to = number->at + order.at[i];
        if (c->seed != PBW_NONE && w->input->seed_regions != NULL) {
            *to = w->input->seed_regions[c->seed];
        } else {
            *to = kept || c->seed != PBW_NONE ? next++ : PBW_NONE;
        }
        w->report->regions += *to != PBW_NONE;
    }
    PBW_RELEASE(&w->memory, keys);
    PBW_RELEASE(&w->memory, order);
    return status;
}

/* Refuses facets that bound no region. */
static pbw_status pbwfill__check_closed(pbwfill__work *w)
{
    pbw_status status = PBW_OK;
    size_t i;
    int k;
    pbwfill__clear(&w->covered);
    for (i = 0; i < w->tets.count; i++) {
        const pbwfill__tet *t = w->tets.at + i;
        if (pbwfill__tick(w, 1)) {
            return PBW_CANCELLED;
        }
        for (k = 0; t->v[0] != PBW_NONE && k < 4; k++) {
            if (t->wall[k] != PBW_NONE && t->n[k] < i && w->region.at[i] == PBW_NONE
                && w->region.at[t->n[k]] == PBW_NONE) {
                const pbw_index triangle = w->members.at[w->facet_first.at[t->wall[k]]];
                pbw_index *told = pbwfill__put(w, &w->covered, triangle, PBW_NONE, PBW_NONE);
                if (told == NULL) {
                    return PBW_ERROR_MEMORY;
                }
                if (*told == PBW_NONE) {
                    status = pbwfill__refuse(w, PBW_FILL_OPEN, triangle, PBW_NONE);
                    *told = 0;
                }
            }
        }
    }
    if (status == PBW_OK && w->report->regions == 0) {
        status = pbwfill__refuse(w, PBW_FILL_EMPTY, PBW_NONE, PBW_NONE);
    }
    return status;
}

static pbw_status pbwfill__find_regions(pbwfill__work *w)
{
    pbwfill__map map;
    pbwfill__indices number = { NULL, 0, 0 };
    pbw_status status;
    size_t i;
    memset(&map, 0, sizeof map);
    status = pbwfill__find_components(w, &map, w->at.at[w->inputs]);
    status = status != PBW_OK ? status : pbwfill__find_contacts(w, &map);
    status = status != PBW_OK ? status : pbwfill__find_depths(w, &map);
    status = status != PBW_OK ? status : pbwfill__take_seeds(w, &map);
    status = status != PBW_OK ? status : pbwfill__number_regions(w, &map, &number);
    for (i = 0; status == PBW_OK && i < w->tets.count; i++) {
        if (w->region.at[i] != PBW_NONE) {
            w->region.at[i] = number.at[w->region.at[i]];
        }
    }
    PBW_RELEASE(&w->memory, map.components);
    PBW_RELEASE(&w->memory, map.contacts);
    PBW_RELEASE(&w->memory, map.body);
    PBW_RELEASE(&w->memory, map.around);
    PBW_RELEASE(&w->memory, number);
    return status != PBW_OK ? status : pbwfill__check_closed(w);
}

/* ------------------------------------------------------------------------------------------------------
   >>exact        Points taken off the surface's edges again.
   In: the constrained triangulation; regions.  Out: one with fewer vertices on edges of facets, or none.
   The tetrahedra at such a point v are wedges between facets that meet at its edge.  Without v, each facet's faces at
   v become others over the same polygon; these and the faces across from v enclose what is to be filled.  Tetrahedra
   that are positive and that closed faces link fill it without overlap, as its boundary is that of the wedge.  So all
   faces are joined to one of their vertices that sees them, if there is one; else the wedge is wrapped as a facet's
   cavity is.  A wedge of no region keeps its tetrahedra, with v: flat ones between v and the new faces link them to
   these.  If there are no such tetrahedra, a copy of v moves into the wedge: faces across from v have v on their
   positive side, so also all places near v, and the new faces in the wedge's planes have all places within it.  The
   places on the positive side of all faces are convex, and the copy climbs there as far from the nearest plane as it
   can.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWFILL__WRAPPED = 60,              /* most faces of wedges that are wrapped first */
       PBWFILL__STAR = 1500,               /* most tetrahedra at a point */
       PBWFILL__MENDED = 300,              /* most of other cavities that are filled again */
       PBWFILL__EFFORT = 30000 };          /* most tetrahedra of stars that are tried for one point */

typedef struct pbwfill__sector { pbw_index triangle, x, y; int wedge; } pbwfill__sector;   /* the face v x y of the
                                                             triangle, the wedge is on its positive side */
typedef struct pbwfill__ear {              /* from the edge's a on to its b */
    pbw_index triangle, v[3];
    pbw_index ends[2];                     /* the vertices of the face beside a and of that beside b */
} pbwfill__ear;

typedef struct pbwfill__star {             /* of one vertex on an edge between the vertices a and b */
    pbw_index v, a, b;
    int wedges;
    size_t wrapped;                        /* most faces of wedges that are wrapped */
    PBW_ARRAY(pbwfill__sector) sectors;
    PBW_ARRAY(pbwfill__ear) ears;
    pbwfill__indices regions;              /* of the wedges, from 1 on */
    pbwfill__indices polygon, before, after;         /* before, after: of each vertex that was added on an edge, the
                                                        vertices beside it there; PBW_NONE of others */
} pbwfill__star;

typedef struct pbwfill__wedge {            /* to be filled: the space within faces of this `side` */
    int number, may_add;                   /* may_add: a new vertex */
    pbw_index region, v;                   /* v: a vertex that has all old faces, if the region is PBW_NONE */
    size_t wrapped;                        /* most faces if it is to be wrapped */
    double from[3], inward[3];             /* where a new vertex may be: near `from`, in this direction */
    pbwfill__rest rest;                    /* what `from` lacks */
} pbwfill__wedge;

/* Adds the tetrahedra at v to the cavity, which those in it are linked to.  Returns 0 without memory. */
static int pbwfill__add_star(pbwfill__work *w, pbw_index v)
{
    size_t i;
    unsigned k;
    if (w->seen.at[w->at.at[v]] != w->epoch && !PBW_PUSH(&w->memory, w->cavity, w->at.at[v])) {
        return 0;
    }
    w->seen.at[w->at.at[v]] = w->epoch;
    for (i = 0; i < w->cavity.count; i++) {
        for (k = 0; k < 4; k++) {
            const pbwfill__tet *t = w->tets.at + w->cavity.at[i];
            const pbw_index n = t->n[k];
            if (pbwfill__corner_of(t, v) < 4 && t->v[k] != v && w->seen.at[n] != w->epoch) {
                w->seen.at[n] = w->epoch;
                if (!PBW_PUSH(&w->memory, w->cavity, n)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Makes the tetrahedra at v the cavity. */
static int pbwfill__open_star(pbwfill__work *w, pbw_index v)
{
    w->cavity.count = 0;
    w->epoch += 2;
    return pbwfill__add_star(w, v);
}

/* Lists the tetrahedra at v and numbers their wedges from 1 on: w->epoch + wedge in `seen`.  Returns 0 without
   memory. */
static int pbwfill__find_wedges(pbwfill__work *w, pbwfill__star *star)
{
    size_t i, next;
    unsigned k;
    star->wedges = 0;
    if (!pbwfill__open_star(w, star->v)) {
        return 0;
    }
    for (next = 0; next < w->cavity.count; next++) {
        if (w->seen.at[w->cavity.at[next]] != w->epoch) {
            continue;
        }
        star->wedges++;
        w->list.count = 0;
        if (!PBW_PUSH(&w->memory, w->list, w->cavity.at[next])) {
            return 0;
        }
        w->seen.at[w->cavity.at[next]] = w->epoch + (uint32_t)star->wedges;
        for (i = 0; i < w->list.count; i++) {
            const pbwfill__tet *t = w->tets.at + w->list.at[i];
            for (k = 0; k < 4; k++) {
                if (t->v[k] != star->v && t->wall[k] == PBW_NONE && w->seen.at[t->n[k]] == w->epoch) {
                    w->seen.at[t->n[k]] = w->epoch + (uint32_t)star->wedges;
                    if (!PBW_PUSH(&w->memory, w->list, t->n[k])) {
                        return 0;
                    }
                }
            }
        }
    }
    return 1;
}

/* Lists the faces of tetrahedron t of a wedge: those across from v, or, if the wedge is of no region, the walls at v,
   seen from behind; and the sectors of either. */
static int pbwfill__list_tet(pbwfill__work *w, pbwfill__star *star, pbw_index t)
{
    const pbwfill__tet *tet = w->tets.at + t;
    const int wedge = (int)(w->seen.at[t] - w->epoch), kept = w->region.at[t] != PBW_NONE;
    unsigned j, k;
    for (k = 0; k < 4; k++) {
        const int across = tet->v[k] == star->v;
        pbwfill__face f;
        memset(&f, 0, sizeof f);
        for (j = 0; j < 3; j++) {
            f.v[j] = tet->v[PBW_FACET_CORNER(k, 2 - j)];
        }
        if (!across && tet->wall[k] != PBW_NONE) {
            const unsigned at = f.v[0] == star->v ? 0 : f.v[1] == star->v ? 1 : 2;
            pbwfill__sector s;
            s.triangle = tet->wall[k];
            s.x = f.v[(at + 1) % 3];
            s.y = f.v[(at + 2) % 3];
            s.wedge = wedge;
            if (!PBW_PUSH(&w->memory, star->sectors, s)) {
                return 0;
            }
        }
        if (kept ? !across : across || tet->wall[k] == PBW_NONE) {
            continue;
        }
        f.outside = kept ? tet->n[k] : t;
        f.back = !kept ? k : f.outside == PBW_NONE ? 0 : pbwfill__back(w->tets.at + f.outside, t);
        f.wall = kept ? tet->wall[k] : PBW_NONE;
        f.side = wedge;
        f.tet = PBW_NONE;
        if (!kept) {
            const pbw_index first = f.v[0];
            f.v[0] = f.v[1], f.v[1] = first;
        }
        if (!PBW_PUSH(&w->memory, w->faces, f)) {
            return 0;
        }
    }
    return 1;
}

/* Lists the faces of the wedges, and the sectors; in the cavity stay the tetrahedra that are of a region. */
static int pbwfill__list_star(pbwfill__work *w, pbwfill__star *star)
{
    size_t i, kept = 0;
    w->faces.count = star->sectors.count = star->regions.count = 0;
    if (!PBW_RESERVE(&w->memory, star->regions, (size_t)star->wedges + 1)) {
        return 0;
    }
    for (i = 0; i < w->cavity.count; i++) {
        const pbw_index t = w->cavity.at[i];
        star->regions.at[w->seen.at[t] - w->epoch] = w->region.at[t];
        if (!pbwfill__list_tet(w, star, t)) {
            return 0;
        }
        if (w->region.at[t] != PBW_NONE) {
            w->cavity.at[kept++] = t;
        }
    }
    w->cavity.count = kept;
    return 1;
}

/* Cuts ears off the polygon, in the plane of a triangle.  Returns 1; 0 if it has none; -1 without memory, or if the
   caller cancels. */
static int pbwfill__cut_ears(pbwfill__work *w, pbwfill__star *star, pbw_index triangle)
{
    const pbw_index *c = w->corners.at + 3 * (size_t)w->members.at[w->facet_first.at[triangle]];
    pbw_index *p = star->polygon.at;
    size_t n = star->polygon.count, i, j;
    const pbw_index second = p[1], last = p[n - 2];
    const int axis = pbwfill__axis_of(w, pbwfill__at(w, c[0]), pbwfill__at(w, c[1]), pbwfill__at(w, c[2]));
    const int turn = pbwfill__turn(w, pbwfill__at(w, star->v), pbwfill__at(w, p[0]), pbwfill__at(w, p[1]), axis);
    while (n >= 3) {
        const size_t before = n;
        for (i = 0; i < before; i++) {
            const double *a = pbwfill__at(w, p[(i + n - 1) % n]), *b = pbwfill__at(w, p[i]);
            const double *d = pbwfill__at(w, p[(i + 1) % n]);
            if (n > 3 && (i == 0 || i == n - 1)) {
                continue;                            /* the ends of the edge stay until the last */
            }
            if (pbwfill__turn(w, a, b, d, axis) != turn) {
                continue;
            }
            for (j = 2; j < n - 1; j++) {
                const double *q = pbwfill__at(w, p[(i + j) % n]);
                if (j % 8 == 7 && pbwfill__tick(w, 0)) {
                    return -1;
                }
                if (pbwfill__turn(w, a, b, q, axis) != -turn && pbwfill__turn(w, b, d, q, axis) != -turn
                    && pbwfill__turn(w, d, a, q, axis) != -turn) {
                    break;
                }
            }
            if (j >= n - 1) {
                pbwfill__ear ear;
                ear.triangle = triangle;
                ear.ends[0] = second, ear.ends[1] = last;
                ear.v[0] = p[(i + n - 1) % n], ear.v[1] = p[i], ear.v[2] = p[(i + 1) % n];
                if (!PBW_PUSH(&w->memory, star->ears, ear)) {
                    return -1;
                }
                memmove(p + i, p + i + 1, (n - i - 1) * sizeof *p);
                n--;
                break;
            }
        }
        if (n == before) {
            return 0;
        }
    }
    return 1;
}

/* Lists the triangles without v, from a on to b, of each triangle at the edge.  Returns as pbwfill__cut_ears does. */
static int pbwfill__find_ears(pbwfill__work *w, pbwfill__star *star)
{
    const size_t count = star->sectors.count;
    size_t i, j;
    int found = 1;
    star->ears.count = 0;
    for (i = 0; i < count && found > 0; i++) {
        const pbwfill__sector *first = star->sectors.at + i;
        pbw_index last = first->x, at = first->y;
        if (first->x != star->a) {
            continue;
        }
        star->polygon.count = 0;
        if (!PBW_PUSH(&w->memory, star->polygon, last)) {
            return -1;
        }
        while (at != star->b && star->polygon.count <= count) {
            if (!PBW_PUSH(&w->memory, star->polygon, at)) {
                return -1;
            }
            for (j = 0; j < count; j++) {
                const pbwfill__sector *s = star->sectors.at + j;
                if (s->triangle == first->triangle && s->wedge == first->wedge && s->x == at && s->y != last) {
                    break;
                }
            }
            if (j == count) {
                return 0;
            }
            last = at;
            at = star->sectors.at[j].y;
        }
        if (!PBW_PUSH(&w->memory, star->polygon, at)) {
            return -1;
        }
        found = pbwfill__cut_ears(w, star, first->triangle);
    }
    return found;
}

/* Adds the ears to the faces of the wedges on both of their sides. */
static int pbwfill__close_wedges(pbwfill__work *w, pbwfill__star *star)
{
    size_t i, j;
    for (i = 0; i < star->sectors.count; i++) {
        const pbwfill__sector *s = star->sectors.at + i;
        for (j = 0; j < star->ears.count && (s->x == star->a || s->x == star->b); j++) {
            const pbwfill__ear *ear = star->ears.at + j;
            pbwfill__face f;
            if (ear->triangle != s->triangle || ear->ends[s->x == star->b] != s->y) {
                continue;
            }
            memset(&f, 0, sizeof f);
            f.v[0] = ear->v[0];
            f.v[1] = ear->v[s->x == star->a ? 1 : 2];
            f.v[2] = ear->v[s->x == star->a ? 2 : 1];
            f.outside = f.tet = PBW_NONE;
            f.wall = s->triangle;
            f.side = s->wedge;
            if (!PBW_PUSH(&w->memory, w->faces, f)) {
                return 0;
            }
        }
    }
    return 1;
}

/* The unit normal of a face, into the wedge. */
static void pbwfill__normal(const pbwfill__work *w, const pbw_index v[3], double n[3])
{
    const double *a = pbwfill__at(w, v[0]), *b = pbwfill__at(w, v[1]), *c = pbwfill__at(w, v[2]);
    double length;
    int k;
    for (k = 0; k < 3; k++) {
        const int p = (k + 1) % 3, q = (k + 2) % 3;
        n[k] = (b[p] - a[p]) * (c[q] - a[q]) - (b[q] - a[q]) * (c[p] - a[p]);
    }
    length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (k = 0; k < 3; k++) {
        n[k] /= length;
    }
}

/* How far x is above the plane of a face with the normal n. */
static double pbwfill__height(const pbwfill__work *w, const pbw_index v[3], const double n[3], const double *x)
{
    const double *a = pbwfill__at(w, v[0]);
    return n[0] * (x[0] - a[0]) + n[1] * (x[1] - a[1]) + n[2] * (x[2] - a[2]);
}

/* Sets the normals of the wedge's faces. */
static void pbwfill__find_normals(pbwfill__work *w, int wedge)
{
    size_t i;
    for (i = 0; i < w->faces.count; i++) {
        if (w->faces.at[i].side == wedge) {
            pbwfill__normal(w, w->faces.at[i].v, w->faces.at[i].n);
        }
    }
}

/* How far x is inside of the plane that it is the least inside of, among the wedge's; n: that plane's normal. */
static double pbwfill__depth(const pbwfill__work *w, int wedge, const double x[3], double n[3])
{
    double least = HUGE_VAL;
    size_t i;
    for (i = 0; i < w->faces.count; i++) {
        const pbwfill__face *f = w->faces.at + i;
        const double depth = f->side == wedge ? pbwfill__height(w, f->v, f->n, x) : HUGE_VAL;
        if (depth < least) {
            least = depth;
            memcpy(n, f->n, sizeof f->n);
        }
    }
    return least;
}

/* Whether all tetrahedra of the wedge's faces and x are positive; no if the caller cancels. */
static int pbwfill__sees_all(pbwfill__work *w, int wedge, const double x[PBWFILL__PLACE])
{
    size_t i;
    for (i = 0; i < w->faces.count; i++) {
        const pbwfill__face *f = w->faces.at + i;
        if ((i % 16 == 15 && pbwfill__tick(w, 0))
            || (f->side == wedge && pbwfill__orient3(w, pbwfill__at(w, f->v[0]), pbwfill__at(w, f->v[1]),
                                                     pbwfill__at(w, f->v[2]), x) <= 0)) {
            return 0;
        }
    }
    return 1;
}

/* Moves x away from the plane that it is the least inside of, among the wedge's, while that helps, by `step` and
   less; where x sees all faces, so does the place that it moves to. */
static void pbwfill__climb(pbwfill__work *w, int wedge, double x[PBWFILL__PLACE], double step, int tries)
{
    double n[3], m[3], y[PBWFILL__PLACE] = { 0, 0, 0, 0 }, depth;
    int k, seen;
    pbwfill__round(w, x);
    seen = pbwfill__sees_all(w, wedge, x);
    pbwfill__find_normals(w, wedge);
    depth = pbwfill__depth(w, wedge, x, n);
    while (tries-- > 0) {
        double other;
        for (k = 0; k < 3; k++) {
            y[k] = x[k] + step * n[k];
        }
        pbwfill__round(w, y);
        other = pbwfill__depth(w, wedge, y, m);
        if (other > depth && (!seen || pbwfill__sees_all(w, wedge, y))) {
            depth = other;
            memcpy(x, y, sizeof y);
            memcpy(n, m, sizeof m);
        } else {
            step /= 2;
        }
    }
}

/* Finds a place in the wedge from which all of its faces are seen, where no triple of doubles is, as near to
   `from` as need be.  Returns 0 if there is none, or memory is short: then w->starved. */
static int pbwfill__find_fine_place(pbwfill__work *w, const pbwfill__wedge *wedge, double step,
                                    double x[PBWFILL__PLACE])
{
    const double *d = wedge->inward;
    pbwfill__rest none;
    int k, i, tries, found = 0;
    memset(&none, 0, sizeof none);
    none.ends[0] = none.ends[1] = PBW_NONE;
    x[3] = (double)w->rests.count;
    w->starved = !PBW_PUSH(&w->memory, w->rests, none);
    for (tries = 0; tries < 100 && !w->starved && !found; tries++, step /= 2) {
        for (k = 0; k < 3; k++) {
            double parts[8];
            pbwfill__sum n;
            n.part = parts;
            n.count = 0;
            for (i = 2; i >= 0; i--) {
                pbwfill__add(&n, wedge->rest.part[k][i]);
            }
            pbwfill__add(&n, wedge->from[k]);
            pbwfill__add(&n, pbwfill__is_in_range(step * d[k]) ? step * d[k] : 0);
            pbwfill__split_parts(w, &n, x + k, w->rests.at[w->rests.count - 1].part[k]);
        }
        found = pbwfill__sees_all(w, wedge->number, x);
    }
    w->rests.count -= !w->starved && !found;
    return found;
}

/* Finds a place in the wedge from which all of its faces are seen.  Returns 0 if there is none, or memory is short:
   then w->starved. */
static int pbwfill__find_place(pbwfill__work *w, const pbwfill__wedge *wedge, double x[PBWFILL__PLACE])
{
    const double *p = wedge->from, *d = wedge->inward;
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    double reach = 0, step;
    size_t i;
    int k, tries;
    for (i = 0; i < w->faces.count; i++) {
        const pbwfill__face *f = w->faces.at + i;
        for (k = 0; k < 3 && f->side == wedge->number; k++) {
            reach = fmax(reach, pbwfill__distance(p, pbwfill__at(w, f->v[k])));
        }
    }
    for (tries = 0, step = reach; tries < 60 && length > 0; tries++, step /= 2) {
        for (k = 0; k < 3; k++) {
            x[k] = p[k] + step * d[k] / length;
        }
        pbwfill__round(w, x);
        if (pbwfill__sees_all(w, wedge->number, x)) {
            pbwfill__climb(w, wedge->number, x, step, 24);
            return 1;
        }
    }
    return length > 0 && w->has_rests && pbwfill__find_fine_place(w, wedge, reach / length, x);
}

/* The direction from v into a wedge: the sum of the normals of its two sides. */
static void pbwfill__find_inward(const pbwfill__work *w, const pbwfill__star *star, pbwfill__wedge *wedge)
{
    double *d = wedge->inward, n[3];
    size_t i;
    int k;
    d[0] = d[1] = d[2] = 0;
    for (i = 0; i < star->sectors.count; i++) {      /* those at a: one of each side of the wedge */
        const pbwfill__sector *s = star->sectors.at + i;
        if (s->wedge == wedge->number && (s->x == star->a || s->y == star->a)) {
            pbw_index face[3];
            face[0] = star->v, face[1] = s->x, face[2] = s->y;
            pbwfill__normal(w, face, n);
            for (k = 0; k < 3; k++) {
                d[k] += n[k];
            }
        }
    }
    if (sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) > 1e-6) {
        return;
    }
    for (i = 0; i < 3 * w->faces.count; i++) {       /* all around one triangle: away from it */
        const pbwfill__face *f = w->faces.at + i / 3;
        for (k = 0; k < 3 && f->side == wedge->number; k++) {
            d[k] += pbwfill__at(w, f->v[i % 3])[k] - wedge->from[k];
        }
    }
}

/* Takes walls off the tetrahedra of no region before which there are flat ones now, and puts those made in their
   places. */
static pbw_status pbwfill__replace_wedges(pbwfill__work *w)
{
    const pbwfill__indices floor = { NULL, 0, 0 };
    size_t i;
    for (i = 0; i < w->faces.count; i++) {
        const pbwfill__face *f = w->faces.at + i;
        if (f->outside != PBW_NONE && f->wall == PBW_NONE && w->region.at[f->outside] == PBW_NONE) {
            w->tets.at[f->outside].wall[f->back] = PBW_NONE;
        }
    }
    return pbwfill__replace(w, PBW_NONE, &floor);
}

/* Lists the vertices of a wedge's faces.  Returns the number of these, PBW_NONE without memory. */
static size_t pbwfill__list_wedge(pbwfill__work *w, int wedge)
{
    size_t i, k, faces = 0;
    w->list.count = 0;
    pbwfill__clear(&w->table);
    for (i = 0; i < w->faces.count; i++) {
        const pbwfill__face *f = w->faces.at + i;
        faces += f->side == wedge;
        for (k = 0; f->side == wedge && k < 3; k++) {
            pbw_index *seen = pbwfill__put(w, &w->table, f->v[k], PBW_NONE, PBW_NONE);
            if (seen == NULL || (*seen == PBW_NONE && !PBW_PUSH(&w->memory, w->list, f->v[k]))) {
                return PBW_NONE;
            }
            *seen = 0;
        }
    }
    return faces;
}

/* Whether u sees all faces of the wedge but its own, and is farther than *depth from their planes; sets that. */
static int pbwfill__is_hub(pbwfill__work *w, int wedge, pbw_index u, double *depth)
{
    const double *x = pbwfill__at(w, u), most = *depth;
    size_t i;
    int exact;
    *depth = HUGE_VAL;
    for (exact = 0; exact < 2; exact++) {
        for (i = 0; i < w->faces.count && *depth > most; i++) {
            const pbwfill__face *f = w->faces.at + i;
            if (f->side != wedge || f->v[0] == u || f->v[1] == u || f->v[2] == u) {
                continue;
            }
            if (exact && ((i % 16 == 15 && pbwfill__tick(w, 0))
                          || pbwfill__orient(w, f->v[0], f->v[1], f->v[2], u) <= 0)) {
                return 0;
            }
            *depth = fmin(*depth, pbwfill__height(w, f->v, f->n, x));
        }
    }
    return *depth > most;
}

/* Returns the vertex of the wedge's faces that sees all of these but its own: the one that is the farthest from
   their planes; PBW_NONE if there is none, or the caller cancels. */
static pbw_index pbwfill__find_hub(pbwfill__work *w, int wedge)
{
    pbw_index best = PBW_NONE;
    double most = 0;
    size_t i;
    pbwfill__find_normals(w, wedge);
    for (i = 0; i < w->list.count && !w->cancelled; i++) {
        double depth = most;
        if (pbwfill__is_hub(w, wedge, w->list.at[i], &depth)) {
            most = depth;
            best = w->list.at[i];
        }
    }
    return best;
}

/* Fills a wedge: one of no region from its vertex v, without volume; others from one of their vertices, wrapped, or
   around a new vertex. */
static pbw_status pbwfill__fill_wedge(pbwfill__work *w, const pbwfill__wedge *wedge)
{
    const size_t base = w->made.count, faces = pbwfill__list_wedge(w, wedge->number);
    const pbw_index hub = wedge->region == PBW_NONE ? wedge->v : pbwfill__find_hub(w, wedge->number);
    pbwfill__indices floor = { NULL, 0, 0 };
    pbw_status status = faces == PBW_NONE ? PBW_ERROR_MEMORY : hub == PBW_NONE ? PBW_DEGENERATE
                      : pbwfill__join(w, wedge->number, hub);
    double x[PBWFILL__PLACE] = { 0, 0, 0, 0 };
    if (status == PBW_DEGENERATE && faces <= wedge->wrapped && wedge->region != PBW_NONE) {
        w->made.count = base;
        status = pbwfill__wrap(w, wedge->number, base + 3 * faces + 30, &floor);
    }
    w->starved = 0;
    if (status == PBW_DEGENERATE && wedge->may_add && wedge->region != PBW_NONE && pbwfill__find_place(w, wedge, x)) {
        w->made.count = base;
        if (!pbwfill__new_vertex(w, x)) {
            return PBW_ERROR_MEMORY;
        }
        w->sign.at[w->sign.count - 1] = 1;
        status = pbwfill__join(w, wedge->number, (pbw_index)(pbwfill__vertices(w) - 1));
    }
    status = w->starved ? PBW_ERROR_MEMORY : status;
    while (status == PBW_OK && w->made_region.count < w->made.count) {
        status = PBW_PUSH(&w->memory, w->made_region, wedge->region) ? PBW_OK : PBW_ERROR_MEMORY;
    }
    PBW_RELEASE(&w->memory, floor);
    return status;
}

/* Removes v, which is at the star's, from all of its wedges.  *done: 0 if it has to stay. */
static pbw_status pbwfill__remove(pbwfill__work *w, pbwfill__star *star, int *done)
{
    pbwfill__wedge wedge;
    pbw_status status = PBW_OK;
    int ears;
    *done = 0;
    w->made.count = w->made_region.count = 0;
    if (!pbwfill__find_wedges(w, star) || !pbwfill__list_star(w, star)) {
        return PBW_ERROR_MEMORY;
    }
    w->epoch += (uint32_t)star->wedges;
    w->ticks += w->cavity.count / 4;
    ears = w->cavity.count <= PBWFILL__STAR ? pbwfill__find_ears(w, star) : 0;
    if (ears <= 0) {
        return ears < 0 ? PBW_ERROR_MEMORY : PBW_OK;
    }
    if (!pbwfill__close_wedges(w, star)) {
        return PBW_ERROR_MEMORY;
    }
    memcpy(wedge.from, pbwfill__at(w, star->v), sizeof wedge.from);
    wedge.rest = w->rests.at[(size_t)pbwfill__at(w, star->v)[3]];
    wedge.v = star->v;
    wedge.wrapped = star->wrapped;
    wedge.may_add = star->a != PBW_NONE;
    for (wedge.number = 1; wedge.number <= star->wedges && status == PBW_OK; wedge.number++) {
        wedge.region = star->regions.at[wedge.number];
        pbwfill__find_inward(w, star, &wedge);
        status = pbwfill__fill_wedge(w, &wedge);
    }
    if (status != PBW_OK) {
        return status == PBW_DEGENERATE ? PBW_OK : status;
    }
    *done = 1;
    w->at.at[star->v] = PBW_NONE;
    return pbwfill__replace_wedges(w);
}

/* Lists the neighbours of added vertices on their edges. */
static int pbwfill__list_chains(pbwfill__work *w, pbwfill__star *star)
{
    const size_t count = pbwfill__vertices(w);
    size_t i;
    if (!PBW_ZEROS(&w->memory, star->before, count) || !PBW_ZEROS(&w->memory, star->after, count)) {
        return 0;
    }
    memset(star->before.at, 0xff, count * sizeof *star->before.at);  /* PBW_NONE */
    memset(star->after.at, 0xff, count * sizeof *star->after.at);
    for (i = 0; i < w->pieces.count; i++) {
        const pbwfill__piece *p = w->pieces.at + i;
        if (w->edges.at[p->edge].count > 0 && p->a >= w->inputs) {
            star->after.at[p->a] = p->b;
        }
        if (w->edges.at[p->edge].count > 0 && p->b >= w->inputs) {
            star->before.at[p->b] = p->a;
        }
    }
    return 1;
}

/* Takes vertices before `count` off the edges, the last one first.  Counts in *taken, and in *left those that have to
   stay; the last pass reports these. */
static pbw_status pbwfill__clear_edges(pbwfill__work *w, pbwfill__star *star, size_t count, int last, size_t *taken,
                                       size_t *left)
{
    pbw_status status = PBW_OK;
    size_t i;
    *taken = *left = 0;
    for (i = count; i-- > w->inputs + 8 && status == PBW_OK;) {
        int done = 0;
        star->v = (pbw_index)i;
        star->a = star->before.at[i];
        star->b = star->after.at[i];
        if (star->a == PBW_NONE) {
            continue;                                /* on a wire, or off */
        }
        status = pbwfill__tick(w, (double)(count - i) / (double)count) ? PBW_CANCELLED
               : pbwfill__remove(w, star, &done);
        if (status == PBW_OK && done) {
            star->before.at[i] = PBW_NONE;
            if (star->a >= w->inputs) {
                star->after.at[star->a] = star->b;
            }
            if (star->b >= w->inputs) {
                star->before.at[star->b] = star->a;
            }
        } else if (status == PBW_OK && last) {
            (void)pbwfill__refuse(w, PBW_FILL_POINTS_LEFT, w->members.at[w->facet_first.at[star->sectors.count > 0
                                  ? star->sectors.at[0].triangle : 0]], PBW_NONE);
        }
        *taken += (size_t)done;
        *left += (size_t)!done;
    }
    return status;
}

/* Takes all added vertices off the edges, with another pass over those that had to stay while some come off. */
static pbw_status pbwfill__clear_surface(pbwfill__work *w, pbwfill__star *star)
{
    const size_t count = pbwfill__vertices(w);
    pbw_status status = pbwfill__list_chains(w, star) ? PBW_OK : PBW_ERROR_MEMORY;
    size_t taken = 1, left = 1;
    star->wrapped = PBWFILL__WRAPPED;
    while (status == PBW_OK && taken > 0 && left > 0) {
        status = pbwfill__clear_edges(w, star, count, 0, &taken, &left);
        star->wrapped = PBWFILL__STAR;
    }
    if (status == PBW_OK && left > 0) {
        status = pbwfill__clear_edges(w, star, count, 1, &taken, &left);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>diagonals    Flat facets cut into the input's triangles.
   In: the constrained triangulation, in which facets of several coplanar triangles have faces of their own choice,
   without added vertices.  Out: one in which each triangle is a facet, but for those in facets that are left.
   The triangles of a facet are visited from its border inward; at an edge that is there, the two others of a triangle
   are made by flips.  Let x-z be such an edge, and u a vertex to the left of it, of which the faces that x-z crosses
   are convex at u.  Of u's edges that x-z crosses, one is in two faces that are a strictly convex quadrangle: else
   their other ends were on u's side of the line between u's neighbours, but they are on the other side of x-z.  Each
   such flip takes one of these edges off u, and adds no crossing; so there is an end.
   A flip of a-b replaces the tetrahedra around a-b on both sides of the facet.  All places near the middle of a-b,
   but off the plane, see the faces around these; so a vertex there does it where wrapping fails.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwfill__part {             /* a face of a facet of several triangles */
    pbw_index v[3], tets[2];               /* tets[0] is on the positive side of v, in all of the facet alike */
    pbw_index facet, triangle;             /* the input's triangle, PBW_NONE: not yet known */
} pbwfill__part;

typedef struct pbwfill__flats {
    PBW_ARRAY(pbwfill__part) parts;        /* `wall` has the number of facets plus the place in here */
    pbwfill__table sides;                  /* u, v, facet: the part to the left of u-v */
    pbwfill__table hops;                   /* u, v: the first vertex on the input's edge u-v, where that is not v */
    pbwfill__indices queue;                /* sides of triangles, 3 t + k, that are there */
    PBW_ARRAY(unsigned char) visited;      /* of each triangle */
    pbwfill__indices crossed;              /* 2 an edge: its ends on the right and on the left */
    pbw_index facet;                       /* at work; how it is seen: */
    int axis, turn;
} pbwfill__flats;

/* On which side of u-v x is, in the facet at work; left: positive. */
static int pbwfill__left(const pbwfill__work *w, const pbwfill__flats *f, pbw_index u, pbw_index v, pbw_index x)
{
    return f->turn * pbwfill__turn(w, pbwfill__at(w, u), pbwfill__at(w, v), pbwfill__at(w, x), f->axis);
}

/* The part to the left of u-v, PBW_NONE if there is none. */
static pbw_index pbwfill__part_at(const pbwfill__flats *f, pbw_index u, pbw_index v)
{
    return pbwfill__look_up(&f->sides, u, v, f->facet);
}

/* The third vertex of a part. */
static pbw_index pbwfill__apex(const pbwfill__flats *f, pbw_index part, pbw_index u, pbw_index v)
{
    const pbw_index *p = f->parts.at[part].v;
    return p[0] ^ p[1] ^ p[2] ^ u ^ v;
}

/* Begins with a facet: how its first triangle is seen. */
static void pbwfill__see(const pbwfill__work *w, pbwfill__flats *f, pbw_index facet)
{
    const pbw_index *c = w->corners.at + 3 * (size_t)w->members.at[w->facet_first.at[facet]];
    f->facet = facet;
    f->axis = pbwfill__axis_of(w, pbwfill__at(w, c[0]), pbwfill__at(w, c[1]), pbwfill__at(w, c[2]));
    f->turn = pbwfill__turn(w, pbwfill__at(w, c[0]), pbwfill__at(w, c[1]), pbwfill__at(w, c[2]), f->axis);
}

/* Notes the part's sides. */
static int pbwfill__put_sides(pbwfill__work *w, pbwfill__flats *f, pbw_index part)
{
    const pbwfill__part *p = f->parts.at + part;
    int k;
    for (k = 0; k < 3; k++) {
        pbw_index *side = pbwfill__put(w, &f->sides, p->v[k], p->v[(k + 1) % 3], p->facet);
        if (side == NULL) {
            return 0;
        }
        *side = part;
    }
    return 1;
}

/* Lists the parts of all facets of several triangles.  left: gets 1 for facets with an added vertex.  Returns 0
   without memory, or if the caller cancels. */
static int pbwfill__list_parts(pbwfill__work *w, pbwfill__flats *f, unsigned char *left)
{
    size_t i;
    unsigned j, k;
    for (i = 0; i < w->tets.count; i++) {
        if (pbwfill__tick(w, 1)) {
            return 0;
        }
        for (k = 0; w->tets.at[i].v[0] != PBW_NONE && k < 4; k++) {
            pbwfill__tet *t = w->tets.at + i, *n;
            const pbw_index facet = t->wall[k];
            pbwfill__part p;
            if (facet >= w->report->facets || w->facet_first.at[facet + 1] == w->facet_first.at[facet] + 1) {
                continue;
            }
            pbwfill__see(w, f, facet);
            for (j = 0; j < 3; j++) {
                p.v[j] = t->v[PBW_FACET_CORNER(k, 2 - j)];
                left[facet] |= p.v[j] >= w->inputs;
            }
            p.tets[0] = (pbw_index)i;
            p.tets[1] = t->n[k];
            p.facet = facet;
            p.triangle = PBW_NONE;
            n = w->tets.at + p.tets[1];
            n->wall[pbwfill__back(n, (pbw_index)i)] = t->wall[k] = (pbw_index)(w->report->facets + f->parts.count);
            if (pbwfill__left(w, f, p.v[0], p.v[1], p.v[2]) < 0) {
                j = p.v[0], p.v[0] = p.v[1], p.v[1] = j;
                p.tets[0] = p.tets[1];
                p.tets[1] = (pbw_index)i;
            }
            if (!PBW_PUSH(&w->memory, f->parts, p) || !pbwfill__put_sides(w, f, (pbw_index)f->parts.count - 1)) {
                return 0;
            }
        }
    }
    return 1;
}

/* ---- a flip */

/* Lists the tetrahedra around a-b on both sides of the parts p and q at it: w->epoch + side in `seen`.  Returns 0
   without memory, or if there are others there. */
static int pbwfill__list_ring(pbwfill__work *w, const pbwfill__flats *f, pbw_index a, pbw_index b, pbw_index p,
                              pbw_index q)
{
    int side;
    w->epoch += 2;
    w->cavity.count = 0;
    for (side = 0; side < 2; side++) {
        pbw_index t = f->parts.at[p].tets[side], x = pbwfill__apex(f, p, a, b);
        while (w->region.at[t] != PBW_NONE) {
            const pbwfill__tet *tet = w->tets.at + t;
            const unsigned i = pbwfill__corner_of(tet, x);
            w->seen.at[t] = w->epoch + (uint32_t)side;
            if (!PBW_PUSH(&w->memory, w->cavity, t)) {
                w->starved = 1;
                return 0;
            }
            if (tet->wall[i] != PBW_NONE) {
                if (t != f->parts.at[q].tets[side]) {
                    return 0;
                }
                break;
            }
            x = tet->v[0] ^ tet->v[1] ^ tet->v[2] ^ tet->v[3] ^ a ^ b ^ x;
            t = tet->n[i];
        }
    }
    return 1;
}

/* Adds a face of a wedge: v, or its other side. */
static int pbwfill__add_face(pbwfill__work *w, const pbw_index v[3], int turned, int wedge, pbw_index wall,
                             pbw_index outside)
{
    pbwfill__face f;
    memset(&f, 0, sizeof f);
    f.v[0] = v[turned], f.v[1] = v[!turned], f.v[2] = v[2];
    f.outside = outside;
    f.back = outside == PBW_NONE ? 0 : pbwfill__across(w->tets.at + outside, v);
    f.wall = wall;
    f.side = wedge;
    f.tet = PBW_NONE;
    return PBW_PUSH(&w->memory, w->faces, f) != 0;
}

/* Lists the faces of the wedges on both sides of a-b: those around, and the parts p and q as they are to be. */
static int pbwfill__list_wedges(pbwfill__work *w, const pbwfill__flats *f, pbw_index a, pbw_index b,
                                const pbw_index at[2], const pbwfill__part to[2])
{
    size_t i;
    unsigned j;
    int side, good = 1;
    w->faces.count = 0;
    for (i = 0; good && i < w->cavity.count; i++) {
        const pbw_index t = w->cavity.at[i];
        const pbwfill__tet *tet = w->tets.at + t;
        for (j = 0; good && j < 4; j++) {
            const pbw_index n = tet->n[j];
            pbw_index v[3];
            if (tet->v[j] == a || tet->v[j] == b) {
                v[0] = tet->v[PBW_FACET_CORNER(j, 2)];
                v[1] = tet->v[PBW_FACET_CORNER(j, 1)];
                v[2] = tet->v[PBW_FACET_CORNER(j, 0)];
                good = pbwfill__add_face(w, v, 0, (int)(w->seen.at[t] - w->epoch) + 1, tet->wall[j],
                                         n == PBW_NONE || w->seen.at[n] >= w->epoch ? PBW_NONE : n);
            }
        }
    }
    for (i = 0; i < 4 && good; i++) {
        const pbwfill__part *p = f->parts.at + at[i / 2];
        side = (int)(i % 2);
        good = pbwfill__add_face(w, to[i / 2].v, side, side + 1, (pbw_index)w->report->facets + at[i / 2], PBW_NONE)
            && (w->region.at[p->tets[side]] != PBW_NONE
                || pbwfill__add_face(w, p->v, !side, side + 1, PBW_NONE, p->tets[side]));
    }
    return good;
}

/* Sets the tetrahedra of the parts among the faces, which have been filled. */
static void pbwfill__follow_parts(pbwfill__work *w, pbwfill__flats *f)
{
    size_t i;
    for (i = 0; i < w->faces.count; i++) {
        const pbwfill__face *face = w->faces.at + i;
        if (face->wall != PBW_NONE && face->wall >= w->report->facets) {
            pbwfill__part *p = f->parts.at + (face->wall - w->report->facets);
            const int k = face->v[0] == p->v[0] ? 0 : face->v[1] == p->v[0] ? 1 : 2;
            p->tets[face->v[(k + 1) % 3] != p->v[1]] = face->tet;
        }
    }
}

/* Replaces the edge a-b between two parts by the one between their other corners.  Returns PBW_DEGENERATE if it
   cannot. */
static pbw_status pbwfill__flip(pbwfill__work *w, pbwfill__flats *f, pbw_index a, pbw_index b)
{
    const pbw_index at[2] = { pbwfill__part_at(f, a, b), pbwfill__part_at(f, b, a) };
    const pbw_index c = pbwfill__apex(f, at[0], a, b), d = pbwfill__apex(f, at[1], a, b);
    pbwfill__part to[2];
    pbw_status status = PBW_OK;
    pbwfill__wedge wedge;
    int k;
    if (pbwfill__is_wire(w, a, b)) {
        return pbwfill__refuse(w, PBW_FILL_CROSSING, w->members.at[w->facet_first.at[f->facet]], PBW_NONE);
    }
    to[0] = f->parts.at[at[0]], to[1] = f->parts.at[at[1]];
    to[0].v[0] = c, to[0].v[1] = a, to[0].v[2] = d;
    to[1].v[0] = d, to[1].v[1] = b, to[1].v[2] = c;
    w->made.count = w->made_region.count = 0;
    w->starved = 0;
    if (!pbwfill__list_ring(w, f, a, b, at[0], at[1])) {
        return w->starved ? PBW_ERROR_MEMORY : PBW_DEGENERATE;
    }
    if (!pbwfill__list_wedges(w, f, a, b, at, to)) {
        return PBW_ERROR_MEMORY;
    }
    pbwfill__normal(w, to[0].v, wedge.inward);
    pbwfill__between_exactly(w, pbwfill__at(w, a), pbwfill__at(w, b), 0.5, wedge.from, &wedge.rest);
    wedge.v = b;
    wedge.wrapped = PBWFILL__WRAPPED;
    wedge.may_add = 1;
    for (wedge.number = 1; wedge.number <= 2 && status == PBW_OK; wedge.number++) {
        wedge.region = w->region.at[to[0].tets[wedge.number - 1]];
        status = pbwfill__fill_wedge(w, &wedge);
        for (k = 0; k < 3; k++) {
            wedge.inward[k] = -wedge.inward[k];
        }
    }
    status = status != PBW_OK ? status : pbwfill__replace_wedges(w);
    if (status != PBW_OK) {
        return status;
    }
    for (k = 0; k < 2; k++) {
        pbw_index *gone = pbwfill__put(w, &f->sides, k == 0 ? a : b, k == 0 ? b : a, f->facet);
        if (gone == NULL) {
            return PBW_ERROR_MEMORY;
        }
        *gone = PBW_NONE;
    }
    f->parts.at[at[0]] = to[0];
    f->parts.at[at[1]] = to[1];
    pbwfill__follow_parts(w, f);
    return pbwfill__put_sides(w, f, at[0]) && pbwfill__put_sides(w, f, at[1]) ? PBW_OK : PBW_ERROR_MEMORY;
}

/* ---- an edge of the input */

/* Finds the part x u[0] u[1] that the way from x to z begins in, or on a side of which it is: counterclockwise from
   x-y on, else clockwise.  Returns 0 if there is none. */
static int pbwfill__find_way(const pbwfill__work *w, const pbwfill__flats *f, pbw_index x, pbw_index y, pbw_index z,
                             pbw_index u[2])
{
    int back;
    for (back = 0; back < 2; back++) {
        pbw_index part;
        u[!back] = y;
        do {
            u[back] = u[!back];
            part = back ? pbwfill__part_at(f, u[1], x) : pbwfill__part_at(f, x, u[0]);
            if (part == PBW_NONE) {
                break;
            }
            u[!back] = pbwfill__apex(f, part, x, u[back]);
            if (pbwfill__left(w, f, x, u[0], z) >= 0 && pbwfill__left(w, f, x, u[1], z) <= 0) {
                return 1;
            }
        } while (u[!back] != y);
    }
    return 0;
}

/* Lists the edges that x-z crosses up to *next, the first vertex on it.  y: as for pbwfill__find_way. */
static pbw_status pbwfill__find_crossed(pbwfill__work *w, pbwfill__flats *f, pbw_index x, pbw_index y, pbw_index z,
                                        pbw_index *next)
{
    pbw_index u[2];
    f->crossed.count = 0;
    if (!pbwfill__find_way(w, f, x, y, z, u)) {
        return PBW_DEGENERATE;
    }
    *next = pbwfill__left(w, f, x, u[0], z) == 0 ? u[0] : u[1];
    if (*next == u[0] || pbwfill__left(w, f, x, u[1], z) == 0) {
        return PBW_OK;
    }
    for (;;) {
        const pbw_index part = pbwfill__part_at(f, u[1], u[0]);
        int side;
        if (part == PBW_NONE) {
            return PBW_DEGENERATE;
        }
        if (!PBW_PUSH(&w->memory, f->crossed, u[0]) || !PBW_PUSH(&w->memory, f->crossed, u[1])) {
            return PBW_ERROR_MEMORY;
        }
        *next = pbwfill__apex(f, part, u[0], u[1]);
        side = pbwfill__left(w, f, x, z, *next);
        if (side == 0) {
            return PBW_OK;
        }
        u[side > 0] = *next;
    }
}

/* The vertices before and behind crossed edge i, of the parts at it; *same: whether the edge between them does not
   cross the way from x to z.  Returns whether these parts are a strictly convex quadrangle. */
static int pbwfill__is_convex(const pbwfill__work *w, const pbwfill__flats *f, size_t i, pbw_index x, pbw_index z,
                              int *same)
{
    const pbw_index *e = f->crossed.at + 2 * i, *last = f->crossed.at + f->crossed.count - 2;
    const int before = i > 0 && e[-2] == e[0], behind = e < last && e[2] == e[0];        /* on the left */
    const pbw_index p = i == 0 ? x : before ? e[-1] : e[-2], q = e == last ? z : behind ? e[3] : e[2];
    *same = i == 0 || e == last || before == behind;
    return pbwfill__left(w, f, p, e[0], q) > 0 && pbwfill__left(w, f, q, e[1], p) > 0;
}

/* Chooses one of the crossed edges to be flipped: one of which the flip takes a crossing off, or one at a convex
   vertex on the left.  Returns their number if there is none. */
static size_t pbwfill__choose_flip(const pbwfill__work *w, const pbwfill__flats *f, pbw_index x, pbw_index z)
{
    const size_t count = f->crossed.count / 2;
    const pbw_index *e = f->crossed.at;
    size_t i, j, k;
    int same;
    for (i = 0; i < count; i++) {
        if (pbwfill__is_convex(w, f, i, x, z, &same) && same) {
            return i;
        }
    }
    for (i = 0; i < count; i = j) {
        const pbw_index u = e[2 * i + 1], before = i == 0 ? x : e[2 * i - 1];
        for (j = i; j < count && e[2 * j + 1] == u; j++) {
        }
        for (k = i; k < j && pbwfill__left(w, f, before, j == count ? z : e[2 * j + 1], u) > 0; k++) {
            if (pbwfill__is_convex(w, f, k, x, z, &same)) {
                return k;
            }
        }
    }
    return count;
}

/* Notes a piece of the input's edge. */
static int pbwfill__note_piece(pbwfill__work *w, pbw_index u, pbw_index v)
{
    pbw_index *border = pbwfill__put(w, &w->borders, u < v ? u : v, u < v ? v : u, PBW_NONE);
    return border != NULL && (*border = 0, 1);
}

/* Notes the first vertex on the way from u to v. */
static int pbwfill__note_hop(pbwfill__work *w, pbwfill__flats *f, pbw_index u, pbw_index v, pbw_index first)
{
    pbw_index *hop = first == v ? &first : pbwfill__put(w, &f->hops, u, v, PBW_NONE);
    return hop != NULL && (*hop = first, 1);
}

static pbw_index pbwfill__hop(const pbwfill__flats *f, pbw_index u, pbw_index v)
{
    const pbw_index first = pbwfill__look_up(&f->hops, u, v, PBW_NONE);
    return first == PBW_NONE ? v : first;
}

/* Makes the edge x-z, or edges between the vertices on it; the edge x-y is there, and x y z counterclockwise. */
static pbw_status pbwfill__make_edge(pbwfill__work *w, pbwfill__flats *f, pbw_index x, pbw_index y, pbw_index z)
{
    const pbw_index start = x;
    pbw_index at = x, from = pbwfill__hop(f, x, y), next;
    while (at != z) {
        pbw_status status = pbwfill__find_crossed(w, f, at, from, z, &next);
        while (status == PBW_OK && f->crossed.count > 0) {
            const size_t i = pbwfill__choose_flip(w, f, at, next);
            status = pbwfill__tick(w, 1) ? PBW_CANCELLED : 2 * i == f->crossed.count ? PBW_DEGENERATE
                   : pbwfill__flip(w, f, f->crossed.at[2 * i], f->crossed.at[2 * i + 1]);
            status = status != PBW_OK ? status : pbwfill__find_crossed(w, f, at, from, z, &next);
        }
        if (status == PBW_OK && !(pbwfill__note_piece(w, at, next) && (at != start
                                  || pbwfill__note_hop(w, f, x, z, next)))) {
            status = PBW_ERROR_MEMORY;
        }
        if (status != PBW_OK) {
            return status;
        }
        from = at;
        at = next;
    }
    return pbwfill__note_hop(w, f, z, start, from) ? PBW_OK : PBW_ERROR_MEMORY;
}

/* ---- a facet */

/* Side s of a triangle as seen in the facet at work: from x to y, z is on the left. */
static void pbwfill__see_side(const pbwfill__work *w, const pbwfill__flats *f, pbw_index s, pbw_index *x,
                              pbw_index *y, pbw_index *z)
{
    const size_t t = s - s % 3;
    const pbw_index a = w->corners.at[t + (s + 1) % 3], b = w->corners.at[t + (s + 2) % 3];
    *z = w->corners.at[s];
    *x = pbwfill__left(w, f, a, b, *z) > 0 ? a : b;
    *y = a ^ b ^ *x;
}

/* Notes the pieces of the facet's border, and queues its sides.  Returns 0 without memory, or if the caller
   cancels. */
static int pbwfill__queue_border(pbwfill__work *w, pbwfill__flats *f)
{
    size_t i;
    f->queue.count = 0;
    pbwfill__clear(&w->borders);
    pbwfill__clear(&f->hops);
    for (i = 3 * (size_t)w->facet_first.at[f->facet]; i < 3 * (size_t)w->facet_first.at[f->facet + 1]; i++) {
        const size_t s = 3 * (size_t)w->members.at[i / 3] + i % 3;
        const pbwfill__edge *e = w->edges.at + w->edge_of.at[s];
        pbw_index piece, last = e->a;
        if (pbwfill__tick(w, 1)) {
            return 0;
        }
        for (piece = e->piece; piece != PBW_NONE; piece = w->pieces.at[piece].next) {
            const pbw_index b = w->pieces.at[piece].b;
            if (b < w->inputs) {
                if (!pbwfill__note_piece(w, last, b) || (last == e->a && !pbwfill__note_hop(w, f, last, e->b, b))
                    || (b == e->b && !pbwfill__note_hop(w, f, b, e->a, last))) {
                    return 0;
                }
                last = b;
            }
        }
        if (e->piece != PBW_NONE && !PBW_PUSH(&w->memory, f->queue, (pbw_index)s)) {
            return 0;
        }
    }
    return 1;
}

/* Makes the edges of all of the facet's triangles. */
static pbw_status pbwfill__make_edges_of(pbwfill__work *w, pbwfill__flats *f)
{
    pbw_status status = pbwfill__queue_border(w, f) ? PBW_OK : PBW_ERROR_MEMORY;
    size_t i;
    unsigned k;
    for (i = 0; i < f->queue.count && status == PBW_OK; i++) {
        const pbw_index s = f->queue.at[i], t = s - s % 3;
        pbw_index x, y, z;
        if (f->visited.at[s / 3]) {
            continue;
        }
        f->visited.at[s / 3] = 1;
        pbwfill__see_side(w, f, s, &x, &y, &z);
        status = pbwfill__make_edge(w, f, x, y, z);
        status = status != PBW_OK ? status : pbwfill__make_edge(w, f, z, x, y);
        for (k = 1; k < 3 && status == PBW_OK; k++) {
            const pbw_index side = t + (s + k) % 3;
            const pbwfill__edge *e = w->edges.at + w->edge_of.at[side];
            if (e->piece == PBW_NONE) {
                const pbw_index *sides = w->sides.at + e->first;
                status = PBW_PUSH(&w->memory, f->queue, sides[sides[0] == side]) ? PBW_OK : PBW_ERROR_MEMORY;
            }
        }
    }
    return status;
}

/* Gives the facet's parts their triangles: one for each, but where other points of the input lie in it.  Returns 0
   without memory, or if the caller cancels. */
static int pbwfill__find_triangles(pbwfill__work *w, pbwfill__flats *f)
{
    size_t i;
    int k;
    for (i = w->facet_first.at[f->facet]; i < w->facet_first.at[f->facet + 1]; i++) {
        const pbw_index t = w->members.at[i];
        pbw_index x, y, z;
        pbwfill__see_side(w, f, 3 * t, &x, &y, &z);
        f->queue.count = 0;
        if (!PBW_PUSH(&w->memory, f->queue, pbwfill__part_at(f, x, pbwfill__hop(f, x, y)))) {
            return 0;
        }
        while (f->queue.count > 0) {
            pbwfill__part *p = f->parts.at + f->queue.at[--f->queue.count];
            if (pbwfill__tick(w, 1)) {
                return 0;
            }
            p->triangle = t;
            for (k = 0; k < 3; k++) {
                const pbw_index u = p->v[k], v = p->v[(k + 1) % 3];
                const pbw_index part = pbwfill__part_at(f, v, u);
                if (pbwfill__look_up(&w->borders, u < v ? u : v, u < v ? v : u, PBW_NONE) == PBW_NONE
                    && f->parts.at[part].triangle == PBW_NONE && !PBW_PUSH(&w->memory, f->queue, part)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Makes facets of the triangles, but of those in facets that are left.  Returns 0 without memory, or if the caller
   cancels. */
static int pbwfill__split_facets(pbwfill__work *w, const pbwfill__flats *f, const unsigned char *left)
{
    const size_t facets = w->report->facets;
    pbwfill__indices number = { NULL, 0, 0 };
    size_t i, next = 0;
    if (!PBW_FIT(&w->memory, number, facets + 1)) {
        return 0;
    }
    for (i = 0; i < w->corners.count / 3; i++) {     /* by first triangles, as before */
        pbw_index *facet = w->facet_of.at + i;
        if (*facet != PBW_NONE) {
            const int first = w->members.at[w->facet_first.at[*facet]] == i;
            const pbw_index new_number = first || !left[*facet] ? (pbw_index)next++ : number.at[*facet];
            number.at[*facet] = first ? new_number : number.at[*facet];
            *facet = new_number;
        }
    }
    for (i = 0; i < 4 * w->tets.count && !pbwfill__tick(w, 1); i++) {
        pbw_index *wall = w->tets.at[i / 4].wall + i % 4;
        if (w->tets.at[i / 4].v[0] != PBW_NONE && *wall != PBW_NONE) {
            const pbwfill__part *p = *wall < facets ? NULL : f->parts.at + (*wall - facets);
            *wall = p == NULL ? number.at[*wall] : p->triangle == PBW_NONE ? number.at[p->facet]
                  : w->facet_of.at[p->triangle];
        }
    }
    w->report->facets = next;
    memset(w->facet_first.at, 0, (next + 2) * sizeof *w->facet_first.at);
    pbwfill__list_members(w);
    PBW_RELEASE(&w->memory, number);
    return !w->cancelled;
}

/* Cuts flat facets into the input's triangles, but for those with added vertices, and *failed others; the last call
   reports these. */
static pbw_status pbwfill__cut_facets(pbwfill__work *w, int last, size_t *failed)
{
    pbwfill__flats f;
    PBW_ARRAY(unsigned char) left = { NULL, 0, 0 };
    pbw_status status;
    size_t i;
    memset(&f, 0, sizeof f);
    status = PBW_ZEROS(&w->memory, left, w->report->facets + 1)
          && PBW_ZEROS(&w->memory, f.visited, w->corners.count / 3 + 1)
          && pbwfill__list_parts(w, &f, left.at) ? PBW_OK : PBW_ERROR_MEMORY;
    for (i = 0; i < w->report->facets && status == PBW_OK; i++) {
        if (w->facet_first.at[i + 1] == w->facet_first.at[i] + 1 || left.at[i]) {
            continue;
        }
        pbwfill__see(w, &f, (pbw_index)i);
        status = pbwfill__tick(w, 1) ? PBW_CANCELLED : pbwfill__make_edges_of(w, &f);
        if (status == PBW_OK && !pbwfill__find_triangles(w, &f)) {
            status = PBW_ERROR_MEMORY;
        }
        if (status == PBW_DEGENERATE && w->report->refusal != PBW_FILL_CROSSING) {
            status = PBW_OK;
            left.at[i] = 1;
            *failed += 1;
            if (last) {
                (void)pbwfill__refuse(w, PBW_FILL_POINTS_LEFT, w->members.at[w->facet_first.at[i]], PBW_NONE);
            }
        }
    }
    if (status == PBW_OK && !pbwfill__split_facets(w, &f, left.at)) {
        status = PBW_ERROR_MEMORY;
    }
    PBW_RELEASE(&w->memory, left);
    PBW_RELEASE(&w->memory, f.parts);
    PBW_RELEASE(&w->memory, f.sides.slots);
    PBW_RELEASE(&w->memory, f.hops.slots);
    PBW_RELEASE(&w->memory, f.queue);
    PBW_RELEASE(&w->memory, f.crossed);
    PBW_RELEASE(&w->memory, f.visited);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>spared       Added points inside taken off.
   In: tetrahedra with regions, the input's triangles as facets.  Out: fewer vertices inside.
   The tetrahedra at such a point are filled again as a wedge is, without it.  Where that fails, one of its neighbours
   takes them: the tetrahedra behind faces that it does not see are taken, too, until it sees all faces, or there is a
   facet that it does not see.  Else a new point, from which they are seen, takes these and those at a neighbour that
   was added as well; so there is one point less.
   ------------------------------------------------------------------------------------------------------ */
/* Whether a tetrahedron has an edge of a wire. */
static int pbwfill__has_wire(const pbwfill__work *w, const pbwfill__tet *t)
{
    unsigned i, j;
    for (i = 0; i < 4 && w->wires.slots.count > 0; i++) {
        for (j = 0; j < i; j++) {
            if (pbwfill__is_wire(w, t->v[i], t->v[j])) {
                return 1;
            }
        }
    }
    return 0;
}

/* Whether a tetrahedron is kept, but not positive. */
static int pbwfill__is_turned(const pbwfill__work *w, size_t t)
{
    const pbw_index *c = w->tets.at[t].v;
    return c[0] != PBW_NONE && w->region.at[t] != PBW_NONE && pbwfill__orient(w, c[0], c[1], c[2], c[3]) <= 0;
}

/* Adds the tetrahedra behind the cavity's faces, but for walls; turned: only turned ones, and those behind them.
   Returns 0 without memory. */
static int pbwfill__add_ring(pbwfill__work *w, int turned)
{
    const size_t before = w->cavity.count;
    size_t i;
    unsigned k;
    for (i = 0; i < (turned ? w->cavity.count : before) && w->cavity.count <= PBWFILL__MENDED; i++) {
        for (k = 0; k < 4; k++) {
            const pbwfill__tet *t = w->tets.at + w->cavity.at[i];
            const pbw_index n = t->n[k];
            if (n != PBW_NONE && t->wall[k] == PBW_NONE && w->seen.at[n] != w->epoch
                && !pbwfill__has_wire(w, w->tets.at + n) && (!turned || pbwfill__is_turned(w, n))) {
                w->seen.at[n] = w->epoch;
                if (!PBW_PUSH(&w->memory, w->cavity, n)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Adds the tetrahedra behind faces that the place x does not see to the cavity; u: the vertex at x, or PBW_NONE.
   Returns 0 if facets are in the way, or without memory. */
static int pbwfill__grow(pbwfill__work *w, pbw_index u, const double x[PBWFILL__PLACE])
{
    size_t i;
    unsigned k, j;
    w->starved = 0;
    for (i = 0; i < w->cavity.count; i++) {
        for (k = 0; k < 4; k++) {
            const pbwfill__tet *t = w->tets.at + w->cavity.at[i];
            const pbw_index n = t->n[k];
            const int wall = n == PBW_NONE || t->wall[k] != PBW_NONE;
            const double *c[4];
            for (j = 0; j < 4; j++) {
                c[j] = j == k ? x : pbwfill__at(w, t->v[j]);
            }
            if (pbwfill__corner_of(t, u) < 4 || (!wall && w->seen.at[n] == w->epoch)
                || pbwfill__orient3(w, c[0], c[1], c[2], c[3]) > 0) {
                continue;
            }
            if (wall || w->cavity.count >= PBWFILL__STAR) {
                return 0;
            }
            w->seen.at[n] = w->epoch;
            if (!PBW_PUSH(&w->memory, w->cavity, n)) {
                w->starved = 1;
                return 0;
            }
        }
    }
    return 1;
}

/* Puts those made in the place of the cavity.  *done: 0 if this has a wire, or a vertex before number `first` that is
   not in `list`. */
static pbw_status pbwfill__replace_inside(pbwfill__work *w, size_t first, int *done)
{
    size_t i;
    pbwfill__clear(&w->table);
    for (i = 0; i < w->list.count; i++) {
        pbw_index *kept = pbwfill__put(w, &w->table, w->list.at[i], PBW_NONE, PBW_NONE);
        if (kept == NULL) {
            return PBW_ERROR_MEMORY;
        }
        *kept = 0;
    }
    for (i = 0; i < 4 * w->cavity.count; i++) {
        const pbwfill__tet *t = w->tets.at + w->cavity.at[i / 4];
        if ((t->v[i % 4] < first && pbwfill__look_up(&w->table, t->v[i % 4], PBW_NONE, PBW_NONE) == PBW_NONE)
            || (i % 4 == 0 && pbwfill__has_wire(w, t))) {
            return PBW_OK;
        }
    }
    *done = 1;
    for (i = 0; i < 4 * w->cavity.count; i++) {      /* those of new tetrahedra get one */
        w->at.at[w->tets.at[w->cavity.at[i / 4]].v[i % 4]] = PBW_NONE;
    }
    return pbwfill__replace_wedges(w);
}

/* Fills the cavity, and what has to be added to it, from the vertex u, or a new one if that is PBW_NONE, at x.
   *done: 0 if that fails. */
static pbw_status pbwfill__join_grown(pbwfill__work *w, pbw_index u, const double x[PBWFILL__PLACE], size_t first,
                                      int *done)
{
    pbw_status status;
    w->made.count = w->made_region.count = 0;
    w->ticks += w->cavity.count / 4;
    if (pbwfill__tick(w, 1)) {
        return PBW_CANCELLED;
    }
    if (!pbwfill__grow(w, u, x)) {
        return w->starved ? PBW_ERROR_MEMORY : PBW_OK;
    }
    if (u == PBW_NONE) {
        u = (pbw_index)pbwfill__vertices(w);
        if (!pbwfill__new_vertex(w, x)) {
            return PBW_ERROR_MEMORY;
        }
        w->sign.at[u] = 1;
    }
    if (!pbwfill__list_faces(w) || pbwfill__list_wedge(w, 1) == PBW_NONE || !PBW_PUSH(&w->memory, w->list, u)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbwfill__join(w, 1, u);
    return status == PBW_OK ? pbwfill__replace_inside(w, first, done) : status == PBW_DEGENERATE ? PBW_OK : status;
}

/* Removes v, which is inside, and all other vertices from number `first` on that only tetrahedra of the cavity have:
   into one of its neighbours, into a new vertex with a neighbour that may go, too, or with the tetrahedra behind
   those at it.  One with a rest may give way to one without, near the middle of an edge of it.  *done: 0 if that
   fails. */
static pbw_status pbwfill__remove_wide(pbwfill__work *w, pbwfill__star *star, size_t first, int *done)
{
    const pbw_index v = star->v;
    pbwfill__wedge wedge;
    pbw_status status = PBW_OK;
    size_t i, effort = 0;
    const int fine = pbwfill__at(w, v)[3] != 0;
    int k, pair;
    star->polygon.count = 0;                         /* the neighbours */
    if (!pbwfill__open_star(w, v) || !pbwfill__list_faces(w)
        || !PBW_RESERVE(&w->memory, star->polygon, w->list.count)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < w->list.count; i++) {
        star->polygon.at[star->polygon.count] = w->list.at[i];
        star->polygon.count += w->list.at[i] != v || fine;
    }
    for (pair = 0; pair < 2; pair++) {
        for (i = 0; i < star->polygon.count && !*done && status == PBW_OK && effort < PBWFILL__EFFORT; i++) {
            const pbw_index u = star->polygon.at[i];
            const double *reach;
            double x[PBWFILL__PLACE];
            if (pair ? u < first && !fine : u == v) {
                continue;
            }
            memcpy(x, pbwfill__at(w, u), sizeof x);
            if (!pbwfill__open_star(w, v)
                || (pair && !((u < first || pbwfill__add_star(w, u)) && pbwfill__list_faces(w)))) {
                return PBW_ERROR_MEMORY;
            }
            effort += w->cavity.count;
            if (pair) {
                x[3] = 0;
                for (k = 0; k < 3; k++) {
                    x[k] = (x[k] + pbwfill__at(w, v)[k]) / 2;
                }
                reach = pbwfill__at(w, star->polygon.at[u == v && i == 0 ? 1 : u == v ? 0 : i]);
                pbwfill__climb(w, 1, x, pbwfill__distance(reach, pbwfill__at(w, v)), 24);
            }
            status = pbwfill__join_grown(w, pair ? PBW_NONE : u, x, first, done);
        }
    }
    if (*done || status != PBW_OK) {
        return status;
    }
    if (!pbwfill__open_star(w, v) || !pbwfill__add_ring(w, 0) || !pbwfill__list_faces(w)) {
        return PBW_ERROR_MEMORY;
    }
    w->made.count = w->made_region.count = 0;
    memset(&wedge, 0, sizeof wedge);
    wedge.number = 1;
    wedge.region = w->region.at[w->cavity.at[0]];
    wedge.wrapped = PBWFILL__WRAPPED;
    status = pbwfill__fill_wedge(w, &wedge);         /* `list` has the vertices of the faces */
    return status == PBW_OK ? pbwfill__replace_inside(w, first, done) : status == PBW_DEGENERATE ? PBW_OK : status;
}

/* Takes the vertices from number `first` on off that can be spared inside, the last one first, with another pass over
   those that had to stay, and at which tetrahedra have changed since, while some come off. */
static pbw_status pbwfill__clear_inside(pbwfill__work *w, pbwfill__star *star, size_t first)
{
    pbw_status status = PBW_OK;
    size_t i, taken = 1;
    star->a = star->b = PBW_NONE;
    star->wrapped = PBWFILL__WRAPPED;
    memset(w->touched.at, 1, w->touched.count);
    while (taken > 0 && status == PBW_OK) {
        taken = 0;
        for (i = pbwfill__vertices(w); i-- > first && status == PBW_OK;) {
            int done = 0;
            star->v = (pbw_index)i;
            if (w->at.at[i] != PBW_NONE && w->touched.at[i]) {
                w->touched.at[i] = 0;
                status = pbwfill__tick(w, 1) ? PBW_CANCELLED : pbwfill__remove(w, star, &done);
                if (status == PBW_OK && !done) {
                    status = pbwfill__remove_wide(w, star, first, &done);
                }
                taken += (size_t)done;
            }
        }
    }
    return status;
}

/* Makes the facets the input's triangles. */
static pbw_status pbwfill__make_exact(pbwfill__work *w)
{
    const size_t count = pbwfill__vertices(w);
    size_t failed = 1;
    int last;
    pbwfill__star star;
    pbw_status status;
    if (w->how.conforming) {
        return PBW_OK;
    }
    memset(&star, 0, sizeof star);
    memset(w->sign.at, 1, w->sign.count);            /* one side only */
    status = pbwfill__clear_surface(w, &star);
    for (last = 0; last < 2 && status == PBW_OK && failed > 0; last++) {       /* points that go make room */
        failed = 0;
        status = pbwfill__cut_facets(w, last, &failed);
        status = status != PBW_OK ? status : pbwfill__clear_inside(w, &star, count);
    }
    PBW_RELEASE(&w->memory, star.sectors);
    PBW_RELEASE(&w->memory, star.ears);
    PBW_RELEASE(&w->memory, star.regions);
    PBW_RELEASE(&w->memory, star.polygon);
    PBW_RELEASE(&w->memory, star.before);
    PBW_RELEASE(&w->memory, star.after);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>inside       Points inside, for sizes and shapes.
   In: the tetrahedra with regions; sizes.  Out: more of them, with the same facets.
   Holds: a new point is the center of the sphere of a tetrahedron that is too large or too slim, or the middle of one
   that is too large.  The tetrahedra of which the spheres hold it, up to facets, give way to its star; those with a
   face that it does not see stay.  It keeps its distance from other points, so that there is an end: the size's 0.6,
   or the shortest edge of a slim tetrahedron; and from facets 0.35 of its distance from points, or of the size.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwfill__inside {
    pbwfill__work *w;
    PBW_ARRAY(double) sizes;               /* of each vertex: edges wanted there, in units of vertices */
    pbwfill__indices now, next;            /* tetrahedra of this round and of the next */
} pbwfill__inside;

/* A length of the caller's in units of vertices. */
static double pbwfill__in_units(const pbwfill__work *w, double length)
{
    return pbwfill__scaled(length, -w->exponent);
}

/* Gives vertices of facets the mean length of the edges of facets at them, others the least of what grows from
   these. */
static pbw_status pbwfill__find_sizes(pbwfill__inside *in)
{
    pbwfill__work *w = in->w;
    const double growth = w->how.growth > 0 ? w->how.growth : 0.3;
    PBW_ARRAY(double) counts = { NULL, 0, 0 };
    size_t i, k, j;
    int changes = 1;
    if (!PBW_ZEROS(&w->memory, counts, pbwfill__vertices(w)) || !PBW_ZEROS(&w->memory, in->sizes, counts.count)) {
        PBW_RELEASE(&w->memory, counts);
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < 4 * w->tets.count; i++) {
        const pbwfill__tet *t = w->tets.at + i / 4;
        for (k = 0; t->v[0] != PBW_NONE && t->wall[i % 4] != PBW_NONE && k < 3; k++) {
            const pbw_index a = t->v[PBW_FACET_CORNER(i % 4, k)], b = t->v[PBW_FACET_CORNER(i % 4, (k + 1) % 3)];
            const double length = pbwfill__distance(pbwfill__at(w, a), pbwfill__at(w, b));
            in->sizes.at[a] += length;
            in->sizes.at[b] += length;
            counts.at[a]++;
            counts.at[b]++;
        }
    }
    for (i = 0; i < counts.count; i++) {
        in->sizes.at[i] = counts.at[i] > 0 ? in->sizes.at[i] / counts.at[i] : HUGE_VAL;
    }
    PBW_RELEASE(&w->memory, counts);
    while (changes) {
        changes = 0;
        for (i = 0; i < 16 * w->tets.count; i++) {
            const pbwfill__tet *t = w->tets.at + i / 16;
            double *to, size;
            k = i / 4 % 4;
            j = i % 4;
            if (t->v[0] == PBW_NONE || j == k || w->region.at[i / 16] == PBW_NONE) {
                continue;
            }
            to = in->sizes.at + t->v[k];
            size = in->sizes.at[t->v[j]]
                 + growth * pbwfill__distance(pbwfill__at(w, t->v[j]), pbwfill__at(w, t->v[k]));
            if (!(*to < HUGE_VAL) && size < HUGE_VAL) {
                *to = size;
                changes = 1;
            }
        }
    }
    return PBW_OK;
}

/* The length of edges that is wanted at p in tetrahedron t, in units. */
static double pbwfill__size_at(const pbwfill__inside *in, pbw_index t, const double *p)
{
    const pbwfill__work *w = in->w;
    const pbwfill__tet *tet = w->tets.at + t;
    double size = HUGE_VAL;
    int k;
    if (w->how.size_at != NULL) {
        double place[3];
        pbwfill__place(w, p, place);
        size = pbwfill__in_units(w, w->how.size_at(w->how.size_user, place));
        size = size > 0 ? size : HUGE_VAL;
    } else if (w->how.size > 0) {
        size = pbwfill__in_units(w, w->how.size);
    } else {
        const double growth = w->how.growth > 0 ? w->how.growth : 0.3;
        for (k = 0; k < 4; k++) {
            size = fmin(size, in->sizes.at[tet->v[k]] + growth * pbwfill__distance(pbwfill__at(w, tet->v[k]), p));
        }
    }
    return size;
}

/* The edges of a regular tetrahedron of the largest volume that tetrahedron t may have. */
static double pbwfill__bound_of(const pbwfill__work *w, pbw_index t)
{
    const pbw_index region = w->region.at[t];
    double volume = w->how.volume > 0 ? w->how.volume : HUGE_VAL;
    if (region < w->how.volume_count && w->how.volumes[region] > 0) {
        volume = fmin(volume, w->how.volumes[region]);
    }
    return pbwfill__in_units(w, cbrt(sqrt(72) * volume));
}

/* Returns how far from other points a point for tetrahedron t must be; 0 if t needs none.  Sets the center of its
   sphere, and its middle.  *large: 0 if it is small enough, 1 if too large for a size that follows the surface, 2 if
   too large for the caller's size or volume. */
static double pbwfill__is_wanting(const pbwfill__inside *in, pbw_index t, double center[3], double middle[3],
                                  int *large)
{
    const pbwfill__work *w = in->w;
    const double *o = pbwfill__at(w, w->tets.at[t].v[0]), ratio = w->how.ratio > 0 ? w->how.ratio : 2;
    const double bound = pbwfill__bound_of(w, t);
    double e[3][3], cross[3][3], square[3], volume, radius = 0, shortest = HUGE_VAL, size;
    int i, k;
    for (i = 0; i < 4; i++) {
        const double *p = pbwfill__at(w, w->tets.at[t].v[i]);
        for (k = i + 1; k < 4; k++) {
            shortest = fmin(shortest, pbwfill__distance(p, pbwfill__at(w, w->tets.at[t].v[k])));
        }
        for (k = 0; i > 0 && k < 3; k++) {
            e[i - 1][k] = p[k] - o[k];
        }
    }
    for (i = 0; i < 3; i++) {
        const double *a = e[(i + 1) % 3], *b = e[(i + 2) % 3];
        square[i] = e[i][0] * e[i][0] + e[i][1] * e[i][1] + e[i][2] * e[i][2];
        for (k = 0; k < 3; k++) {
            cross[i][k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        }
    }
    volume = e[0][0] * cross[0][0] + e[0][1] * cross[0][1] + e[0][2] * cross[0][2];
    for (k = 0; k < 3; k++) {
        const double c = (square[0] * cross[0][k] + square[1] * cross[1][k] + square[2] * cross[2][k]) / (2 * volume);
        radius += c * c;
        center[k] = o[k] + c;
        middle[k] = o[k] + (e[0][k] + e[1][k] + e[2][k]) / 4;
    }
    radius = sqrt(radius);
    size = pbwfill__size_at(in, t, middle);
    *large = sqrt(2) * volume > bound * bound * bound ? 2
           : radius > 0.75 * size ? 1 + (w->how.size > 0 || w->how.size_at != NULL) : 0;
    return *large ? 0.6 * fmin(size, bound) : radius > ratio * shortest ? shortest : 0;
}

/* Goes from tetrahedron t to the one with p.  Returns PBW_NONE where a facet is between them, or the way is long. */
static pbw_index pbwfill__reach(const pbwfill__work *w, pbw_index t, const double *p)
{
    enum { STEPS = 300 };
    unsigned i = 0;
    uint64_t step;
    for (step = 0; step < STEPS && i < 4; step++) {
        const unsigned first = (unsigned)(pbw_mix(step) & 3);
        for (i = 0; i < 4; i++) {
            const unsigned k = (first + i) & 3;
            if (pbwfill__is_beyond(w, w->tets.at + t, k, p)) {
                if (w->tets.at[t].wall[k] != PBW_NONE || w->tets.at[t].n[k] == PBW_NONE) {
                    return PBW_NONE;
                }
                t = w->tets.at[t].n[k];
                break;
            }
        }
    }
    return i == 4 ? t : PBW_NONE;
}

/* Takes tetrahedra with a face that p does not see out of the cavity, until none is left.  Returns 0 if the one that
   p is in would go, too. */
static int pbwfill__trim_cavity(pbwfill__work *w, const double *p)
{
    const pbw_index start = w->cavity.at[0];
    size_t i, kept = 0;
    unsigned k, j;
    int changes = 1;
    while (changes && w->seen.at[start] == w->epoch) {
        changes = 0;
        for (i = 0; i < w->cavity.count; i++) {
            const pbw_index t = w->cavity.at[i];
            for (k = 0; k < 4 && w->seen.at[t] == w->epoch; k++) {
                const double *c[4];
                for (j = 0; j < 4; j++) {
                    c[j] = j == k ? p : pbwfill__at(w, w->tets.at[t].v[j]);
                }
                if (pbwfill__ends_at(w, t, k) && pbwfill__orient3(w, c[0], c[1], c[2], c[3]) <= 0) {
                    w->seen.at[t] = w->epoch + 1;
                    changes = 1;
                }
            }
        }
    }
    for (i = 0; i < w->cavity.count; i++) {
        const pbw_index t = w->cavity.at[i];
        if (w->seen.at[t] == w->epoch) {
            w->cavity.at[kept++] = t;
        }
    }
    w->cavity.count = kept;
    return w->seen.at[start] == w->epoch;
}

/* Whether the cavity may be the star of p: p keeps its distance from vertices and facets; no vertex and no wire is
   within the cavity.  A failure is w->starved. */
static int pbwfill__may_fill(pbwfill__inside *in, const double *p, double spacing, double clearance)
{
    pbwfill__work *w = in->w;
    double nearest = HUGE_VAL;
    size_t i;
    unsigned k, j;
    pbwfill__clear(&w->table);
    for (i = 0; i < 4 * w->cavity.count; i++) {
        const pbw_index t = w->cavity.at[i / 4];
        for (j = 0; pbwfill__ends_at(w, t, (unsigned)(i % 4)) && j < 3; j++) {
            const pbw_index u = w->tets.at[t].v[PBW_FACET_CORNER(i % 4, j)];
            const pbw_index v = w->tets.at[t].v[PBW_FACET_CORNER(i % 4, (j + 1) % 3)];
            w->seen_vertex.at[u] = w->epoch;
            nearest = fmin(nearest, pbwfill__distance(p, pbwfill__at(w, u)));
            if (w->wires.slots.count > 0
                && pbwfill__put(w, &w->table, u < v ? u : v, u < v ? v : u, PBW_NONE) == NULL) {
                w->starved = 1;
                return 0;
            }
        }
    }
    for (i = 0; i < w->cavity.count && nearest >= spacing; i++) {
        const pbwfill__tet *t = w->tets.at + w->cavity.at[i];
        for (k = 0; k < 4; k++) {
            if (w->seen_vertex.at[t->v[k]] != w->epoch) {
                return 0;
            }
            for (j = k + 1; w->wires.slots.count > 0 && j < 4; j++) {
                const pbw_index u = t->v[k] < t->v[j] ? t->v[k] : t->v[j], v = t->v[k] ^ t->v[j] ^ u;
                const pbwfill__slot *s = w->table.slots.count == 0 ? NULL : pbwfill__find(&w->table, u, v, PBW_NONE);
                if (pbwfill__is_wire(w, u, v) && (s == NULL || s->stamp != w->table.stamp)) {
                    return 0;
                }
            }
            if (t->wall[k] != PBW_NONE) {
                double n[3];
                pbw_index face[3];
                for (j = 0; j < 3; j++) {
                    face[j] = t->v[PBW_FACET_CORNER(k, j)];
                }
                pbwfill__normal(w, face, n);
                if (fabs(pbwfill__height(w, face, n, p)) < fmin(0.35 * nearest, clearance)) {
                    return 0;
                }
            }
        }
    }
    return nearest >= spacing;
}

/* Puts a point at p, if that may be; t: a tetrahedron near it.  taken: whether it may. */
static pbw_status pbwfill__try_place(pbwfill__inside *in, pbw_index t, const double wanted[3], double spacing,
                                     double clearance, int *taken)
{
    pbwfill__work *w = in->w;
    const pbw_index vertex = (pbw_index)pbwfill__vertices(w), region = w->region.at[t];
    const double *low = pbwfill__at(w, (pbw_index)w->inputs), *high = pbwfill__at(w, (pbw_index)w->inputs + 7);
    double p[PBWFILL__PLACE] = { 0, 0, 0, 0 }, size;
    size_t i;
    int k;
    *taken = 0;
    for (k = 0; k < 3; k++) {
        if (!(wanted[k] > low[k] && wanted[k] < high[k])) {
            return PBW_OK;
        }
        p[k] = floor(wanted[k] * 1024 + 0.5) / 1024; /* 2^-38 of the box or more: no points for finer details */
    }
    pbwfill__round(w, p);
    t = pbwfill__reach(w, t, p);
    if (t == PBW_NONE) {
        return PBW_OK;
    }
    if (!pbwfill__open_cavity(w, t, p)) {
        return PBW_ERROR_MEMORY;
    }
    if (!pbwfill__trim_cavity(w, p) || !pbwfill__may_fill(in, p, spacing, clearance)) {
        return w->starved ? PBW_ERROR_MEMORY : PBW_OK;
    }
    size = HUGE_VAL;
    for (i = 0; i < 4 * w->cavity.count; i++) {
        const pbw_index v = w->tets.at[w->cavity.at[i / 4]].v[i % 4];
        size = fmin(size, in->sizes.at[v]
                    + (w->how.growth > 0 ? w->how.growth : 0.3) * pbwfill__distance(p, pbwfill__at(w, v)));
    }
    if (!pbwfill__new_vertex(w, p) || !PBW_PUSH(&w->memory, in->sizes, size) || !pbwfill__make_star(w, vertex)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < w->list.count; i++) {
        if (!pbwfill__set_region(w, w->list.at[i], region) || !PBW_PUSH(&w->memory, in->next, w->list.at[i])) {
            return PBW_ERROR_MEMORY;
        }
    }
    w->report->inside_points++;
    *taken = 1;
    return PBW_OK;
}

/* Puts points where tetrahedra are too large or too slim, in rounds, until there are none, or no place for points. */
static pbw_status pbwfill__refine(pbwfill__inside *in)
{
    pbwfill__work *w = in->w;
    const size_t most = w->how.most == 0 ? 50000000 : w->how.most;
    pbw_status status = PBW_OK;
    size_t i, rounds;
    for (rounds = 0; in->next.count > 0 && status == PBW_OK; rounds++) {
        const pbwfill__indices swap = in->now;
        in->now = in->next;
        in->next = swap;
        in->next.count = 0;
        for (i = 0; i < in->now.count && status == PBW_OK; i++) {
            const pbw_index t = in->now.at[i];
            double center[3], middle[3], spacing;
            int large, taken = 1;
            if (pbwfill__tick(w, 1 - 1 / (1 + 0.1 * (double)rounds))) {
                return PBW_CANCELLED;
            }
            if (w->tets.at[t].v[0] == PBW_NONE || w->region.at[t] == PBW_NONE) {
                continue;
            }
            spacing = pbwfill__is_wanting(in, t, center, middle, &large);
            if (spacing > 0) {
                status = pbwfill__try_place(in, t, center, spacing, large ? 0.6 * spacing : HUGE_VAL, &taken);
            }
            if (!taken && large && status == PBW_OK) {
                status = pbwfill__try_place(in, t, middle, spacing, 0.6 * spacing, &taken);
            }
            if (w->report->inside_points > most) {
                return PBW_ERROR_TOO_LARGE;
            }
        }
    }
    return status;
}

static pbw_status pbwfill__add_inside(pbwfill__work *w)
{
    pbwfill__inside in;
    pbw_status status;
    size_t i;
    if (w->how.size_at == NULL && !(w->how.size > 0) && !(w->how.ratio > 0) && !(w->how.volume > 0)
        && w->how.volume_count == 0) {
        return PBW_OK;
    }
    memset(&in, 0, sizeof in);
    in.w = w;
    memset(w->seen_vertex.at, 0, w->seen_vertex.count * sizeof *w->seen_vertex.at);
    status = pbwfill__find_sizes(&in);
    for (i = 0; i < w->tets.count && status == PBW_OK; i++) {
        status = w->region.at[i] == PBW_NONE || w->tets.at[i].v[0] == PBW_NONE
              || PBW_PUSH(&w->memory, in.next, (pbw_index)i) ? PBW_OK : PBW_ERROR_MEMORY;
    }
    status = status != PBW_OK ? status : pbwfill__refine(&in);
    for (i = 0; i < w->tets.count && status == PBW_OK; i++) {
        double center[3], middle[3];
        int large = 0;
        if (w->tets.at[i].v[0] != PBW_NONE && w->region.at[i] != PBW_NONE) {
            w->report->too_slim += pbwfill__is_wanting(&in, (pbw_index)i, center, middle, &large) > 0 && !large;
            w->report->too_large += large == 2;
        }
    }
    PBW_RELEASE(&w->memory, in.sizes);
    PBW_RELEASE(&w->memory, in.now);
    PBW_RELEASE(&w->memory, in.next);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>places       Points on edges at doubles.
   In: tetrahedra with regions, positive.  Out: vertices without rests.
   Tetrahedra that are positive, linked, and bounded by the facets cover what these enclose once, so that signs are
   all that there is to check.  A vertex with a rest goes to the doubles nearest to it, or to some near these from
   which all of its tetrahedra are positive; else those that turn are filled again, with some around.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWFILL__CAVITIES = 12 };           /* of a turned tetrahedron: those around its edges, then rings around it */

/* Adds the tetrahedra around the edge a-b of t, up to walls.  Returns 0 without memory. */
static int pbwfill__add_around(pbwfill__work *w, pbw_index t, pbw_index a, pbw_index b)
{
    const pbw_index *v = w->tets.at[t].v;
    const pbw_index others = v[0] ^ v[1] ^ v[2] ^ v[3] ^ a ^ b;
    unsigned i = 0, side;
    while (v[i] == a || v[i] == b) {
        i++;
    }
    for (side = 0; side < 2; side++) {
        pbw_index from = side == 0 ? w->tets.at[t].v[i] : w->tets.at[t].v[i] ^ others, at = t;
        for (;;) {
            const pbwfill__tet *tet = w->tets.at + at;
            const unsigned k = pbwfill__corner_of(tet, from);
            const pbw_index n = tet->n[k];
            if (n == PBW_NONE || tet->wall[k] != PBW_NONE || w->seen.at[n] == w->epoch
                || pbwfill__has_wire(w, w->tets.at + n)) {
                break;
            }
            from = tet->v[0] ^ tet->v[1] ^ tet->v[2] ^ tet->v[3] ^ a ^ b ^ from;
            at = n;
            w->seen.at[n] = w->epoch;
            if (!PBW_PUSH(&w->memory, w->cavity, n)) {
                return 0;
            }
        }
    }
    return 1;
}

/* Makes the next cavity of a turned tetrahedron.  middle: of the edge, if it is around one; else of its vertices. */
static int pbwfill__next_cavity(pbwfill__work *w, pbw_index t, int number, double middle[3])
{
    static const unsigned char edges[6][2] = { { 0, 1 }, { 0, 2 }, { 0, 3 }, { 1, 2 }, { 1, 3 }, { 2, 3 } };
    const pbw_index *v = w->tets.at[t].v, a = v[edges[number % 6][0]], b = v[edges[number % 6][1]];
    size_t i;
    int k;
    if (number <= 6) {
        w->epoch += 2;
        w->seen.at[t] = w->epoch;
        w->cavity.count = 0;
        if (!PBW_PUSH(&w->memory, w->cavity, t)) {
            return 0;
        }
    }
    if (!(number < 6 ? pbwfill__add_around(w, t, a, b)
          : (number > 6 || pbwfill__add_ring(w, 1)) && pbwfill__add_ring(w, 0))
        || (w->cavity.count <= PBWFILL__MENDED && !pbwfill__list_faces(w))) {
        return 0;
    }
    for (k = 0; k < 3; k++) {
        middle[k] = number < 6 ? (pbwfill__at(w, a)[k] + pbwfill__at(w, b)[k]) / 2 : 0;
        for (i = 0; i < w->list.count && number >= 6; i++) {
            middle[k] += (pbwfill__at(w, w->list.at[i])[k] - middle[k]) / (double)(i + 1);
        }
    }
    return 1;
}

/* Takes added vertices off `list` that are on no face of the cavity, and so may be dropped. */
static void pbwfill__drop_inner(pbwfill__work *w)
{
    size_t i, kept = 0;
    for (i = 0; i < w->list.count; i++) {
        w->touched.at[w->list.at[i]] = 0;
    }
    for (i = 0; i < 3 * w->faces.count; i++) {
        w->touched.at[w->faces.at[i / 3].v[i % 3]] = 1;
    }
    for (i = 0; i < w->list.count; i++) {
        const pbw_index u = w->list.at[i];
        if (w->touched.at[u] || u < w->inputs + 8) {
            w->list.at[kept++] = u;
        }
    }
    w->list.count = kept;
}

/* Whether all vertices of `list` are in tetrahedra made. */
static int pbwfill__made_of_all(pbwfill__work *w)
{
    size_t i;
    unsigned k;
    int all = 1;
    for (i = 0; i < w->list.count; i++) {
        w->touched.at[w->list.at[i]] = 0;
    }
    for (i = 0; i < w->made.count; i++) {
        for (k = 0; k < 4; k++) {
            w->touched.at[w->made.at[i].v[k]] = 1;
        }
    }
    for (i = 0; i < w->list.count; i++) {
        all &= w->touched.at[w->list.at[i]];
    }
    return all;
}

/* Joins the cavity's faces to a new vertex within, looked for from x on. */
static pbw_status pbwfill__join_inside(pbwfill__work *w, double x[PBWFILL__PLACE])
{
    double reach = 0;
    size_t i;
    for (i = 0; i < w->list.count; i++) {
        reach = fmax(reach, pbwfill__distance(x, pbwfill__at(w, w->list.at[i])));
    }
    pbwfill__climb(w, 1, x, reach / 4, 60);
    if (!pbwfill__sees_all(w, 1, x)) {
        return PBW_DEGENERATE;
    }
    if (!pbwfill__new_vertex(w, x)) {
        return PBW_ERROR_MEMORY;
    }
    w->sign.at[w->sign.count - 1] = 1;
    return pbwfill__join(w, 1, (pbw_index)(pbwfill__vertices(w) - 1));
}

/* Fills a turned tetrahedron and some around it again.  *done: whether that is possible. */
static pbw_status pbwfill__mend(pbwfill__work *w, pbw_index t, int *done)
{
    pbwfill__indices floor = { NULL, 0, 0 };         /* stays empty */
    pbw_status status = PBW_OK;
    size_t i;
    int tries;
    *done = 0;
    for (tries = 0; tries < 2 * PBWFILL__CAVITIES && !*done && status == PBW_OK; tries++) {
        double middle[PBWFILL__PLACE] = { 0, 0, 0, 0 };
        if (!pbwfill__next_cavity(w, t, tries % PBWFILL__CAVITIES, middle)) {
            return PBW_ERROR_MEMORY;
        }
        if (w->cavity.count > PBWFILL__MENDED || pbwfill__has_wire(w, w->tets.at + t)) {
            continue;
        }
        w->made.count = 0;
        pbwfill__drop_inner(w);
        status = tries < PBWFILL__CAVITIES ? pbwfill__wrap(w, 1, 3 * w->faces.count + 30, &floor)
               : pbwfill__join_inside(w, middle);
        if (status == PBW_OK && pbwfill__made_of_all(w)) {
            *done = 1;
            for (i = 0; i < 4 * w->made.count; i++) {
                w->seen_vertex.at[w->made.at[i / 4].v[i % 4]] = 0;
            }
            status = pbwfill__replace(w, PBW_NONE, &floor);
        }
        status = status == PBW_DEGENERATE ? PBW_OK : status;
    }
    PBW_RELEASE(&w->memory, floor);
    return status;
}

static pbw_status pbwfill__note_turned(void *arg, size_t from, size_t to)
{
    pbwfill__work *w = (pbwfill__work *)arg;
    size_t i;
    for (i = from; i < to; i++) {
        w->noted.at[i] = (unsigned char)pbwfill__is_turned(w, i);
    }
    return PBW_OK;
}

/* Moves v, which was rounded, so that all of its tetrahedra are positive, if there is such a place: anywhere inside,
   or, at facets and wires, within 2^-42 of the largest coordinate.  Then its neighbours may find one, too.
   Returns 0 without memory. */
static int pbwfill__shift(pbwfill__work *w, pbw_index v)
{
    double *at = w->x.at + PBWFILL__PLACE * (size_t)v, x[PBWFILL__PLACE], reach = 0;
    size_t i;
    unsigned j;
    int inside = 1;
    if (!pbwfill__open_star(w, v)) {
        return 0;
    }
    w->faces.count = 0;
    for (i = 0; i < w->cavity.count; i++) {
        const pbwfill__tet *t = w->tets.at + w->cavity.at[i];
        const unsigned k = pbwfill__corner_of(t, v);
        pbw_index face[3];
        face[0] = t->v[PBW_FACET_CORNER(k, 2)];
        face[1] = t->v[PBW_FACET_CORNER(k, 1)];
        face[2] = t->v[PBW_FACET_CORNER(k, 0)];
        inside &= !pbwfill__has_wire(w, t);
        for (j = 0; j < 3; j++) {
            reach = fmax(reach, pbwfill__distance(at, pbwfill__at(w, face[j])));
            inside &= t->wall[PBW_FACET_CORNER(k, j)] == PBW_NONE;
        }
        if (w->region.at[w->cavity.at[i]] != PBW_NONE && !pbwfill__add_face(w, face, 0, 1, PBW_NONE, PBW_NONE)) {
            return 0;
        }
    }
    memcpy(x, at, sizeof x);
    pbwfill__climb(w, 1, x, inside ? reach / 4 : ldexp(fmax(fmax(fabs(x[0]), fabs(x[1])), fabs(x[2])), -48), 60);
    if (pbwfill__sees_all(w, 1, x)) {
        memcpy(at, x, sizeof x);
        for (i = 0; i < 4 * w->cavity.count; i++) {
            w->seen_vertex.at[w->tets.at[w->cavity.at[i / 4]].v[i % 4]] = 0;
        }
    }
    return 1;
}

/* Makes turned tetrahedra positive, or fills them again.  Counts in *mended those that it could, in *left others. */
static pbw_status pbwfill__mend_all(pbwfill__work *w, size_t vertices, size_t *mended, size_t *left)
{
    const size_t count = w->tets.count;
    pbw_status status = !PBW_FIT(&w->memory, w->noted, count) ? PBW_ERROR_MEMORY
                      : pbw_for(pbwfill__inner_options(w), count, PBWFILL__GRAIN, pbwfill__note_turned, w);
    size_t i, k;
    *mended = *left = 0;
    for (i = 0; i < count && status == PBW_OK; i++) {
        int done = 0;
        if (!w->noted.at[i] || !pbwfill__is_turned(w, i)) {
            continue;
        }
        for (k = 0; k < 4 && !done; k++) {
            const pbw_index v = w->tets.at[i].v[k];
            if (v >= w->inputs + 8 && v < vertices && !w->seen_vertex.at[v]) {
                w->seen_vertex.at[v] = 1;
                if (!pbwfill__shift(w, v)) {
                    return PBW_ERROR_MEMORY;
                }
            }
            done = !pbwfill__is_turned(w, i);
        }
        status = pbwfill__tick(w, 1) ? PBW_CANCELLED : done ? PBW_OK : pbwfill__mend(w, (pbw_index)i, &done);
        *mended += (size_t)done;
        *left += (size_t)!done;
    }
    return status;
}

static pbw_status pbwfill__find_places(pbwfill__work *w)
{
    const size_t vertices = pbwfill__vertices(w);
    pbw_status status = PBW_OK;
    size_t i, mended = 0, left = 1;
    w->made_region.count = 0;
    memset(w->sign.at, 1, w->sign.count);            /* one side only */
    memset(w->seen_vertex.at, 0, w->seen_vertex.count * sizeof *w->seen_vertex.at);
    for (i = w->inputs + 8; i < vertices; i++) {
        double *x = w->x.at + PBWFILL__PLACE * i;
        if (x[3] > 0 && w->at.at[i] != PBW_NONE) {
            pbwfill__round(w, x);
            x[3] = 0;
            mended++;
        }
    }
    while (mended > 0 && left > 0 && status == PBW_OK) {
        status = pbwfill__mend_all(w, vertices, &mended, &left);
        w->report->flat_tets = left;
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>result       The caller's arrays.
   In: the tetrahedra with regions.  Out: those that are kept, their points, and the facets.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwfill__result {
    pbw_memory memory;
    PBW_ARRAY(double) points;
    pbwfill__indices corners, neighbors, regions, original, patches, facets, facet_triangle, facet_corners, sides;
    pbw_tets better;                       /* after improvement: then it holds the arrays of tetrahedra */
} pbwfill__result;

PBWDEF void pbw_fill_free(pbw_filled *filled)
{
    if (filled != NULL && filled->memory != NULL) {
        pbwfill__result *r = (pbwfill__result *)filled->memory;
        pbw_memory memory = r->memory;
        pbw_tets_free(&r->better);
        PBW_RELEASE(&memory, r->points);
        PBW_RELEASE(&memory, r->corners);
        PBW_RELEASE(&memory, r->neighbors);
        PBW_RELEASE(&memory, r->regions);
        PBW_RELEASE(&memory, r->original);
        PBW_RELEASE(&memory, r->patches);
        PBW_RELEASE(&memory, r->facets);
        PBW_RELEASE(&memory, r->facet_triangle);
        PBW_RELEASE(&memory, r->facet_corners);
        PBW_RELEASE(&memory, r->sides);
        (void)pbw_memory_resize(&memory, r, 1, 0, sizeof *r);
    }
    if (filled != NULL) {
        memset(filled, 0, sizeof *filled);
    }
}

/* Numbers the tetrahedra that are kept, and their points: those of the input first, in its order.  Returns 0 without
   memory, or if the caller cancels. */
static int pbwfill__number(pbwfill__work *w, pbwfill__result *r, pbwfill__indices *tet, pbwfill__indices *point)
{
    const size_t count = pbwfill__vertices(w);
    size_t i, k, tets = 0, points = 0;
    if (!PBW_FIT(&w->memory, *tet, w->tets.count) || !PBW_ZEROS(&w->memory, *point, count)) {
        return 0;
    }
    for (i = 0; i < w->tets.count; i++) {
        const int kept = w->tets.at[i].v[0] != PBW_NONE && w->region.at[i] != PBW_NONE;
        if (pbwfill__tick(w, 0)) {
            return 0;
        }
        tet->at[i] = kept ? (pbw_index)tets++ : PBW_NONE;
        for (k = 0; kept && k < 4; k++) {
            point->at[w->tets.at[i].v[k]] = 1;
        }
    }
    for (i = 0; i < count; i++) {
        point->at[i] = point->at[i] ? (pbw_index)points++ : PBW_NONE;
    }
    if (!PBW_FIT(&r->memory, r->points, 3 * points) || !PBW_FIT(&r->memory, r->original, points)
        || !PBW_FIT(&r->memory, r->corners, 4 * tets) || !PBW_FIT(&r->memory, r->neighbors, 4 * tets)
        || !PBW_FIT(&r->memory, r->patches, 4 * tets) || !PBW_FIT(&r->memory, r->regions, tets)) {
        return 0;
    }
    r->original.count = points;
    r->regions.count = tets;
    for (i = 0; i < count; i++) {
        if (point->at[i] != PBW_NONE) {
            pbwfill__place(w, pbwfill__at(w, (pbw_index)i), r->points.at + 3 * (size_t)point->at[i]);
            w->report->inner_points += i >= w->inputs + 8;
            r->original.at[point->at[i]] = i < w->inputs ? (pbw_index)i : PBW_NONE;
        }
    }
    return 1;
}

/* The input's triangle at a face: where a flat facet has several, the one nearest to the middle of the face. */
static pbw_index pbwfill__triangle_at(const pbwfill__work *w, const pbw_surface *surface, const pbw_index v[3],
                                      pbw_index facet)
{
    const pbw_index first = w->facet_first.at[facet];
    double middle[3], place[3];
    pbw_index nearest;
    int k;
    if (w->facet_first.at[facet + 1] == first + 1) {
        return w->members.at[first];
    }
    for (k = 0; k < 3; k++) {
        middle[k] = (pbwfill__at(w, v[0])[k] + pbwfill__at(w, v[1])[k] + pbwfill__at(w, v[2])[k]) / 3;
    }
    nearest = pbw_surface_closest(surface, middle, HUGE_VAL, place);
    return nearest != PBW_NONE && w->facet_of.at[nearest] == facet ? nearest : w->members.at[first];
}

/* Copies the tetrahedra. */
static pbw_status pbwfill__copy(pbwfill__work *w, pbwfill__result *r, const pbw_surface *surface,
                                const pbwfill__indices *tet, const pbwfill__indices *point)
{
    size_t i, j;
    unsigned k;
    for (i = 0; i < w->tets.count; i++) {
        const pbwfill__tet *t = w->tets.at + i;
        const size_t to = tet->at[i];
        for (k = 0; k < 4 && to != PBW_NONE; k++) {
            const pbw_index next = t->n[k] == PBW_NONE ? PBW_NONE : tet->at[t->n[k]];
            pbw_index v[3], triangle = PBW_NONE;
            r->corners.at[4 * to + k] = point->at[t->v[k]];
            r->neighbors.at[4 * to + k] = next;
            if (t->wall[k] != PBW_NONE && next < to) {           /* the other side has it already */
                triangle = r->patches.at[4 * (size_t)next + pbwfill__back(w->tets.at + t->n[k], (pbw_index)i)];
            } else if (t->wall[k] != PBW_NONE) {
                for (j = 0; j < 3; j++) {
                    v[j] = t->v[PBW_FACET_CORNER(k, j)];
                }
                triangle = pbwfill__triangle_at(w, surface, v, t->wall[k]);
                if (pbwfill__tick(w, (double)i / (double)w->tets.count)) {
                    return PBW_CANCELLED;
                }
            }
            r->patches.at[4 * to + k] = triangle;
        }
        if (to != PBW_NONE) {
            r->regions.at[to] = w->region.at[i];
        }
    }
    return PBW_OK;
}

/* Lists the facets, each of the tetrahedron with the lower number.  Returns 0 without memory. */
static int pbwfill__list_facets(pbwfill__result *r, const pbw_tets *tets)
{
    size_t i;
    unsigned k;
    r->facets.count = r->sides.count = r->facet_triangle.count = r->facet_corners.count = 0;
    for (i = 0; i < 4 * tets->tet_count; i++) {
        const pbw_index next = tets->neighbors[i], *c = tets->corners + i / 4 * 4;
        if (tets->patches[i] == PBW_NONE || next < i / 4) {
            continue;
        }
        if (!PBW_RESERVE(&r->memory, r->facets, 3) || !PBW_RESERVE(&r->memory, r->sides, 2)
            || !PBW_PUSH(&r->memory, r->facet_triangle, tets->patches[i])
            || !PBW_PUSH(&r->memory, r->facet_corners, (pbw_index)i)) {
            return 0;
        }
        for (k = 0; k < 3; k++) {
            r->facets.at[r->facets.count++] = c[PBW_FACET_CORNER(i % 4, k)];
        }
        r->sides.at[r->sides.count++] = tets->regions[i / 4];
        r->sides.at[r->sides.count++] = next == PBW_NONE ? PBW_NONE : tets->regions[next];
    }
    return 1;
}

/* What the result holds becomes the caller's view; `original` is always its own. */
static void pbwfill__hand_over(pbwfill__result *r, pbw_filled *filled)
{
    filled->memory = r;
    filled->tets = r->better;
    if (r->better.memory == NULL) {
        filled->tets.points = r->points.at;
        filled->tets.point_count = r->original.count;
        filled->tets.corners = r->corners.at;
        filled->tets.tet_count = r->regions.count;
        filled->tets.neighbors = r->neighbors.at;
        filled->tets.regions = r->regions.at;
        filled->tets.patches = r->patches.at;
    }
    filled->tets.memory = NULL;
    filled->tets.original = r->original.at;
    filled->facets = r->facets.at;
    filled->facet_count = r->facet_triangle.count;
    filled->facet_triangle = r->facet_triangle.at;
    filled->facet_corners = r->facet_corners.at;
    filled->sides = r->sides.at;
}

/* Marks the points of facets and of wires as frozen, and points of the input inside as fixed. */
static void pbwfill__mark_points(const pbwfill__work *w, const pbw_tets *tets, const pbwfill__indices *point,
                                 unsigned char *marks, pbwfill__indices *wires)
{
    size_t i;
    unsigned k;
    for (i = 0; i < tets->point_count; i++) {
        marks[i] = tets->original[i] != PBW_NONE ? PBW_TETS_FIXED : PBW_TETS_FOUND;
    }
    for (i = 0; i < 4 * tets->tet_count; i++) {
        for (k = 0; k < 3 && tets->patches[i] != PBW_NONE; k++) {
            marks[tets->corners[i / 4 * 4 + PBW_FACET_CORNER(i % 4, k)]] = PBW_TETS_FROZEN;
        }
    }
    for (i = 0; i < w->pieces.count; i++) {
        const pbwfill__piece *p = w->pieces.at + i;
        if (w->edges.at[p->edge].count == 0 && point->at[p->a] != PBW_NONE && point->at[p->b] != PBW_NONE) {
            marks[point->at[p->a]] = marks[point->at[p->b]] = PBW_TETS_FROZEN;
            wires->at[wires->count++] = point->at[p->a];
            wires->at[wires->count++] = point->at[p->b];
        }
    }
}

/* The angles of the tetrahedra without a point of the surface. */
static int pbwfill__inner_quality(pbwfill__work *w, const pbw_tets *tets)
{
    pbwfill__indices corners = { NULL, 0, 0 };
    pbw_tets inner;
    size_t i;
    int good = PBW_FIT(&w->memory, corners, 4 * tets->tet_count + 1);
    memset(&inner, 0, sizeof inner);
    for (i = 0; good && i < tets->tet_count; i++) {
        const pbw_index *c = tets->corners + 4 * i;
        const unsigned char *m = tets->marks;
        if (m[c[0]] != PBW_TETS_FROZEN && m[c[1]] != PBW_TETS_FROZEN && m[c[2]] != PBW_TETS_FROZEN
            && m[c[3]] != PBW_TETS_FROZEN) {
            memcpy(corners.at + corners.count, c, 4 * sizeof *c);
            corners.count += 4;
        }
    }
    inner.points = tets->points;
    inner.point_count = tets->point_count;
    inner.corners = corners.at;
    inner.tet_count = corners.count / 4;
    good = good && (inner.tet_count == 0 || pbw_tets_quality(&inner, pbwfill__inner_options(w), &w->report->inner));
    PBW_RELEASE(&w->memory, corners);
    return good;
}

/* Improves the tetrahedra, and keeps the facets. */
static pbw_status pbwfill__improve(pbwfill__work *w, pbwfill__result *r, const pbw_filled *filled,
                                   const pbwfill__indices *point)
{
    pbw_tets in = filled->tets;
    pbwfill__indices wires = { NULL, 0, 0 }, original = { NULL, 0, 0 };
    PBW_ARRAY(unsigned char) marks = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i;
    if (PBW_ZEROS(&w->memory, marks, in.point_count) && PBW_FIT(&w->memory, wires, 2 * w->pieces.count + 1)) {
        pbw_options options = *pbwfill__inner_options(w);
        options.resize = w->caller == NULL ? NULL : w->caller->resize;
        options.resize_user = w->caller == NULL ? NULL : w->caller->resize_user;
        options.memory_limit = pbw_memory_left(&w->memory);
        pbwfill__mark_points(w, &in, point, marks.at, &wires);
        in.marks = marks.at;
        in.edges = wires.at;
        in.edge_count = wires.count / 2;
        status = pbw_improve(&in, &w->how.improve, &options, &r->better, &w->report->improve);
    }
    if (status == PBW_OK && !(PBW_FIT(&r->memory, original, r->better.point_count + 1)
                              && pbwfill__list_facets(r, &r->better) && pbwfill__inner_quality(w, &r->better))) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        w->report->inner_points = 0;
        for (i = 0; i < r->better.point_count; i++) {
            const pbw_index from = r->better.original[i];
            original.at[i] = from == PBW_NONE ? PBW_NONE : r->original.at[from];
            w->report->inner_points += original.at[i] == PBW_NONE;
        }
        PBW_RELEASE(&r->memory, r->original);
        r->original = original;
        PBW_RELEASE(&r->memory, r->points);
        PBW_RELEASE(&r->memory, r->corners);
        PBW_RELEASE(&r->memory, r->neighbors);
        PBW_RELEASE(&r->memory, r->regions);
        PBW_RELEASE(&r->memory, r->patches);
    } else {
        PBW_RELEASE(&r->memory, original);
    }
    PBW_RELEASE(&w->memory, marks);
    PBW_RELEASE(&w->memory, wires);
    return status;
}

static pbw_status pbwfill__write(pbwfill__work *w, pbw_filled *filled)
{
    pbwfill__indices tet = { NULL, 0, 0 }, point = { NULL, 0, 0 };
    pbwfill__doubles points = { NULL, 0, 0 };
    pbw_surface surface;
    pbwfill__result *r = (pbwfill__result *)pbw_memory_resize(&w->memory, NULL, 0, 1, sizeof *r);
    pbw_status status = PBW_OK;
    memset(&surface, 0, sizeof surface);
    if (r == NULL) {
        return PBW_ERROR_MEMORY;
    }
    memset(r, 0, sizeof *r);
    pbw_memory_start(&r->memory, w->caller);
    r->memory.limit = w->memory.limit == 0 ? 0 : pbw_memory_left(&w->memory);
    if (w->report->facets + w->report->doubles + w->report->collapsed < w->corners.count / 3) {
        status = !pbwfill__pack(w, &points) ? PBW_ERROR_MEMORY
               : pbw_surface_create(points.at, w->inputs, w->corners.at, w->corners.count / 3,
                                    pbwfill__inner_options(w), &surface);
    }
    if (status == PBW_OK && !pbwfill__number(w, r, &tet, &point)) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        status = pbwfill__copy(w, r, &surface, &tet, &point);
    }
    pbw_surface_free(&surface);
    PBW_RELEASE(&w->memory, points);
    PBW_RELEASE(&w->memory, tet);
    pbwfill__hand_over(r, filled);
    if (status == PBW_OK) {
        status = pbwfill__list_facets(r, &filled->tets) ? PBW_OK : PBW_ERROR_MEMORY;
        pbwfill__hand_over(r, filled);
    }
    if (status == PBW_OK && w->how.improve.target > 0 && w->report->flat_tets == 0) {
        w->memory.used += r->memory.used;
        status = pbwfill__begin(w, 9, "improve", 1) ? PBW_CANCELLED : pbwfill__improve(w, r, filled, &point);
        w->memory.used -= r->memory.used;
        pbwfill__hand_over(r, filled);
    }
    PBW_RELEASE(&w->memory, point);
    if (status != PBW_OK) {
        pbw_fill_free(filled);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>stages       All of it in order.
   In: the caller's arrays.  Out: the result, or a status and nothing held.
   ------------------------------------------------------------------------------------------------------ */
PBWDEF const char *pbw_fill_refusal(int refusal)
{
    switch (refusal) {
    case PBW_FILL_FILLED: return "filled";
    case PBW_FILL_EMPTY: return "nothing is enclosed";
    case PBW_FILL_CROSSING: return "triangles or segments cross, or touch elsewhere than in common corners and edges";
    case PBW_FILL_FLAT: return "a triangle has no area";
    case PBW_FILL_OPEN: return "the surface is open: a triangle bounds no region";
    case PBW_FILL_TOO_FINE: return "too fine against the box: magnitudes differ by more than doubles hold";
    case PBW_FILL_POINTS_LEFT: return "filled, but points are left on edges of the surface";
    case PBW_FILL_SEED: return "a seed lies on the surface, outside of it, or in the region of another one";
    default: return "unknown";
    }
}

static pbw_status pbwfill__check_input(const pbw_fill_input *in)
{
    size_t i;
    if (in == NULL || (in->point_count > 0 && in->points == NULL) || (in->triangle_count > 0 && in->triangles == NULL)
        || (in->segment_count > 0 && in->segments == NULL) || (in->seed_count > 0 && in->seeds == NULL)) {
        return PBW_ERROR_ARGUMENT;
    }
    if (in->point_count >= PBW_NONE / 16 || in->triangle_count >= PBW_NONE / 16
        || in->segment_count >= PBW_NONE / 16) {
        return PBW_ERROR_TOO_LARGE;
    }
    for (i = 0; i < 3 * in->triangle_count; i++) {
        if (in->triangles[i] >= in->point_count) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    for (i = 0; i < 2 * in->segment_count; i++) {
        if (in->segments[i] >= in->point_count) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    for (i = 0; i < 3 * in->seed_count; i++) {
        if (!(fabs(in->seeds[i]) < HUGE_VAL)) {
            return PBW_ERROR_NOT_FINITE;
        }
    }
    return PBW_OK;
}

static void pbwfill__release(pbwfill__work *w)
{
    pbw_memory *m = &w->memory;
    PBW_RELEASE(m, w->x);
    PBW_RELEASE(m, w->rests);
    PBW_RELEASE(m, w->canonical);
    PBW_RELEASE(m, w->tets);
    PBW_RELEASE(m, w->unused);
    PBW_RELEASE(m, w->at);
    PBW_RELEASE(m, w->seen);
    PBW_RELEASE(m, w->touched);
    PBW_RELEASE(m, w->beyond);
    PBW_RELEASE(m, w->narrow);
    PBW_RELEASE(m, w->noted);
    PBW_RELEASE(m, w->corners);
    PBW_RELEASE(m, w->edges);
    PBW_RELEASE(m, w->sides);
    PBW_RELEASE(m, w->edge_of);
    PBW_RELEASE(m, w->facet_of);
    PBW_RELEASE(m, w->facet_first);
    PBW_RELEASE(m, w->members);
    PBW_RELEASE(m, w->ends_of);
    PBW_RELEASE(m, w->pieces);
    PBW_RELEASE(m, w->table.slots);
    PBW_RELEASE(m, w->borders.slots);
    PBW_RELEASE(m, w->covered.slots);
    PBW_RELEASE(m, w->wires.slots);
    PBW_RELEASE(m, w->cavity);
    PBW_RELEASE(m, w->list);
    PBW_RELEASE(m, w->faces);
    PBW_RELEASE(m, w->made);
    PBW_RELEASE(m, w->sign);
    PBW_RELEASE(m, w->seen_vertex);
    PBW_RELEASE(m, w->region);
    PBW_RELEASE(m, w->made_region);
}

static pbw_status pbwfill__run(pbwfill__work *w, pbw_filled *filled)
{
    typedef pbw_status stage(pbwfill__work *);
    static const struct { const char *name; stage *run; double to; } stages[] = {
        { "vertices", pbwfill__make_vertices, 0.02 }, { "triangulate", pbwfill__triangulate, 0.2 },
        { "edges", pbwfill__find_edges, 0.25 }, { "crossings", pbwfill__check_crossings, 0.3 },
        { "segments", pbwfill__recover_segments, 0.6 }, { "facets", pbwfill__recover_facets, 0.7 },
        { "regions", pbwfill__find_regions, 0.75 }, { "exact", pbwfill__make_exact, 0.85 },
        { "inside", pbwfill__add_inside, 0.95 }
    };
    pbw_status status = PBW_OK;
    int i;
    w->since = clock();
    for (i = 0; i < 9 && status == PBW_OK; i++) {
        status = pbwfill__begin(w, i, stages[i].name, stages[i].to) ? PBW_CANCELLED : stages[i].run(w);
    }
    status = status != PBW_OK ? status : pbwfill__find_places(w);
    status = status != PBW_OK ? status : pbwfill__write(w, filled);
    status = status == PBW_ERROR_MEMORY && w->cancelled ? PBW_CANCELLED : status;    /* of functions that return 0 */
    (void)pbwfill__begin(w, w->stage, NULL, 1);
    return status;
}

PBWDEF pbw_status pbw_fill(const pbw_fill_input *input, const pbw_fill_options *how, const pbw_options *options,
                           pbw_filled *filled, pbw_fill_report *report)
{
    pbw_fill_report own;
    pbwfill__work w;
    pbw_status status;
    report = report == NULL ? &own : report;
    memset(report, 0, sizeof *report);
    if (filled == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(filled, 0, sizeof *filled);
    status = pbwfill__check_input(input);
    if (status != PBW_OK) {
        return status;
    }
    memset(&w, 0, sizeof w);
    w.input = input;
    w.inputs = input->point_count;
    w.caller = options;
    w.report = report;
    pbw_memory_start(&w.memory, options);
    if (options != NULL) {
        w.options.threads = options->threads;
        w.options.run = options->run;
        w.options.run_user = options->run_user;
    }
    if (how != NULL) {
        w.how = *how;
    }
    status = pbwfill__run(&w, filled);
    pbwfill__release(&w);
    return status;
}

PBW_CONTRACTION_ON
#endif /* PBW_FILL_IMPLEMENTATION */
