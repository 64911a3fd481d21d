/* pbw_mesh3.h - v0.2.0 - tetrahedra for the inside of a surface or of an implicit function - MIT-0

   QUICK START
   In one source file, define PBW_MESH3_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file, and the implementations of pbw_surface.h and
   pbw_improve.h in the same source file, before it.

       pbw_solid_input input = {0};
       pbw_tets mesh = {0};
       pbw_solid_report report;
       input.points = points;        input.point_count = n;          // a closed surface, of one or several shells
       input.triangles = triangles;  input.triangle_count = m;
       pbw_solid(&input, NULL, NULL, &mesh, NULL, &report);
       if (report.bad_edges + report.bad_points > 0) puts("no manifold");    // report.places tells where
       pbw_tets_free(&mesh);

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>work         the work in progress: progress, memory, local sizes, points in a grid
     >>input        the surface: welded triangles, or those of an implicit function; its edges
     >>shells       triangles oriented alike; holes closed; regions between walls
     >>inside       which shells are around a point; the label of a place
     >>cuts         where triangles are cut by others
     >>pieces       triangles cut to pieces
     >>union        shells that cross, made one surface
     >>features     which sharp edges are kept
     >>chains       sharp edges chained between corners; patches
     >>sizes        local sizes
     >>samples      the first points: on sharp edges, on smooth parts, inside
     >>labels       the triangulation of the points, and the label of each tetrahedron
     >>manifold     where the boundary is no manifold
     >>reach        points of the surface that the boundary passes by
     >>rounds       points added until nothing is left to add
     >>stars        points where the boundary is no manifold
     >>result       improvement; the boundary; the report
     >>stages       all of it in order

   FUNCTIONS
     pbw_solid                fills a surface with tetrahedra
     pbw_solid_boundary_free  frees its boundary

   HOW
   1. An implicit function is turned into triangles, over the tetrahedra of a cubic grid (Kuhn 1960).  Later, all
      samples of the surface are moved to where it is zero.
   2. Points are placed on sharp edges, on the surface, and on a lattice inside.  Sharp edges cut the surface into
      patches.
   3. Each round triangulates all points and takes the tetrahedra that have their circumcentre inside (restricted
      Delaunay triangulation: Boissonnat and Oudot 2005, "Provably good sampling and meshing of surfaces").  A
      tetrahedron between points of the surface that have no common patch is taken if its middle is inside.
   4. Then the round adds points:
        - where a facet's dual segment meets the surface farther than the size from the facet's corners;
        - where a facet is far from the surface;
        - in the middle of pieces of sharp edges that are no edges of the mesh, and it removes the points in the
          diametral balls of these pieces;
        - where the boundary is no manifold;
        - if there is nothing else to add, on tips and ridges of the surface that are far from the boundary: there
          improvement leaves them where they are, unless tetrahedra stay below the target for that.
      If nothing is left, but tips stay far, as points would be too near to others, the sizes around them are halved,
      up to twice, and rounds go on, unless that leads to faults of the boundary.  Rounds end when none of these is
      left, or after options.rounds.
   5. Where the boundary passes by points of the surface at more than 0.15 sizes, as at horns and pits thinner than
      tetrahedra, some tetrahedra there become parts of the mesh, or leave it, as far as its topology stays.
   6. If the boundary has faults, steps 2 to 4 are repeated: with the surface as one patch; or without sharp edges, if
      only some of them were kept.  The attempt with fewer faults goes on.
   7. pbw_improve raises the least dihedral angle.

   PROMISES  (tests/test_mesh3.c guards them)
     positive    tetrahedra are positively oriented, by exact signs; every point is a corner
     told        the report counts, with places, boundary edges without exactly two facets and points with several
                 fans of facets, with walls for each region's boundary; also missing pieces of sharp edges, open edges
                 of the input, and its sharp edges below 60 degrees
     ends        after options.rounds rounds, whatever the input
     same        the same bytes for any number of threads

   Sizes are those of the options, but smaller where two sheets of the surface are near each other: three quarters of
   their distance, or four thirds if that is below 0.4 sizes, but at least 1/6 of the size, or 1/3 if no sharp edges
   are kept, and at tips 1/12; between shells 1/40, if two million tetrahedra will do; likewise between sharp
   edges that do not meet.  A callback, sizes of regions and, with options.curvature, the curvature lower them, too.
   They grow by options.gradation for each unit of length.
   Triangles of a shell are oriented alike.  Holes of an open surface are reported, and closed by triangles of least
   area (Barequet and Sharir 1995).  If these have more than 0.34 of the surface's area, it is refused, unless
   options.close is 1.  Where open edges form no loops, inside is where the winding number is above 1/2.  Where shells
   cross, touch or lie on each other, or one crosses itself, the surface is cut where triangles meet, and becomes the
   boundary of the union: of all that the shells, turned outward, go around.  Where they cross is then an edge like
   others: where all sharp edges are kept, it is one, too.  With options.nested it is as else.

   Sharp edges below 60 degrees are kept like others; the tetrahedra at them have their angles.

   THREADS
   Samples, rounds, improvement and the report's distance are computed on all threads.  Several threads call `value`,
   `size_at` and the surface's queries at once, whatever options.rounds says, unless options.threads is 1: callbacks
   must not write to what they share.

   Shells may have walls in common, given once or by each of them with the same corners: edges with more than two
   triangles, and no open ones.  Then the regions are enclosed by sides of triangles that see each other across edges;
   walls are interfaces, and edges at which three or more meet are sharp.  Each region's boundary is examined
   separately, and the Euler numbers are sums over regions.

   DOES NOT  settle at gaps of a shell below 1/10 of the size, nor always at acute edges: it warns.  Surfaces with
             walls below about 1/10 of the size on the whole are refused: report.thickness.
             Shells may be nested or cross.  If rounding keeps the pieces of their union from closing, or faces of
             them lie in one plane but for rounding, they are joined without sharp edges where they cross:
             report.united is 0.  Where four walls meet inside, facets of interfaces may cut the corner, by up to
             0.15 sizes: see report.distance.
             Points between two regions are not moved.
             Smooth tips sharper than a cone of 60 degrees may stay farther from the boundary than options.distance.

   CONFIGURATION MACROS
     PBW_MESH3_IMPLEMENTATION    in one source file: compile the implementation there
*/
#ifndef PBW_MESH3_H
#define PBW_MESH3_H
#ifndef PBW_IMPROVE_H
#include "pbw_improve.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbw_solid_input {           /* a surface, or a function */
    const double *points;                  /* 3 coordinates each; points at one place count as one */
    size_t point_count;
    const pbw_index *triangles;            /* 3 ids each, turned any way */
    size_t triangle_count;
    const pbw_index *patches;              /* one a triangle, any numbers: edges between two of them are kept as sharp
                                              ones are; NULL = sharp edges bound the patches */
    /* Or: below zero inside, continuous, and above zero on the box's sides.  Several threads call it at once, also
       with rounds = 0, unless options.threads is 1. */
    double (*value)(void *user, const double point[3]);
    void *value_user;
    double box[6];                         /* low corner, high corner */
} pbw_solid_input;

struct pbw_solid_report;

typedef struct pbw_solid_options {         /* NULL or all zero = best defaults */
    double size;                           /* length of edges, at most; 0 = 1/40 of the box's diagonal */
    double least_size;                     /* local sizes are not below it; 0 = 1/6 of size, 1/16 with size_at, 1/3
                                              where no sharp edges are kept; at tips 1/12 */
    /* The length of edges at a place, where it is below the size.  Several threads call it at once, also with
       rounds = 0, unless options.threads is 1.  NULL = none. */
    double (*size_at)(void *user, const double point[3]);
    void *size_user;
    /* The length of edges in the region of each number below region_size_count, and on its boundary, where it is
       below the size; 0 = the size.  What is thinner than a size of the other regions may get some longer edges.
       NULL = none. */
    const double *region_sizes;
    size_t region_size_count;
    double curvature;                      /* sizes are at most this divided by the curvature, the root of the sum of
                                              both principal ones' squares; 0 = whatever it is.  2 pi / N: a
                                              circle gets N edges */
    double gradation;                      /* sizes grow by at most this for each unit of length; 0 = 0.35 */
    int nested;                            /* 1: shells inside of others bound regions; 0: every second is a cavity,
                                              unless triangles cross: then they are one body */
    int close;                             /* 1: closes holes however large, and fills thin sheets; 0: refuses them */
    int sharp;                             /* which sharp edges are kept: PBW_SOLID_SHARP_... */
    double most;                           /* tetrahedra; 0 = 50 million */
    /* Called once before the first point is laid, with the report so far: what is known of the input, the kept sharp
       edges, the estimate.  NULL = nobody. */
    void (*plan)(void *user, const struct pbw_solid_report *report);
    void *plan_user;
    const char **stage;                    /* gets the name of the stage, before its progress is reported: sample,
                                              rounds, improve or measure, as in report.seconds; NULL = none */
    double feature_angle;                  /* degrees: edges whose normals differ by more are sharp; 0 = 40; functions
                                              have none */
    double distance;                       /* facets farther from the surface, in sizes, get points, and improvement
                                              keeps them within 1.48 times that; places of the surface farther from
                                              the boundary get points, if no others are near; 0 = 0.1 */
    int rounds;                            /* at most; 0 = 16, or 24 where tips need them */
    pbw_improve_options improve;           /* target < 0: no improvement */
} pbw_solid_options;

/* Which sharp edges are kept.  AUTO: an edge that is also sharp between the parts of the surface within a size of it,
   or between planes that go on for three sizes, and part of a chain of several sizes, is a feature.  If 85 % of the
   sharp edges are features, all are kept, as in models from CAD; if at most a third are, none, as in scans; else the
   features. */
enum { PBW_SOLID_SHARP_AUTO, PBW_SOLID_SHARP_ALL, PBW_SOLID_SHARP_SOME, PBW_SOLID_SHARP_NONE };

/* Why a surface is refused, with PBW_DEGENERATE unless said. */
enum {
    PBW_SOLID_FILLED,                      /* it is not */
    PBW_SOLID_OPEN,                        /* its holes are large: report.hole_share */
    PBW_SOLID_THIN,                        /* walls are thinner than 1/10 of the size: report.thickness */
    PBW_SOLID_LARGE,                       /* report.estimate is above options.most; PBW_ERROR_TOO_LARGE */
    PBW_SOLID_LATE                         /* options.improve.seconds were over before the rounds; PBW_CANCELLED */
};

enum { PBW_SOLID_PLACES = 8 };

typedef struct pbw_solid_hole {            /* a loop of open edges of the input */
    size_t edges;
    double length, place[3];               /* place: the mean of its corners */
    int closed;                            /* 1: triangles of least area close it, 0: it is no loop, and the winding
                                              number closes it */
} pbw_solid_hole;

typedef struct pbw_solid_boundary {        /* of the result; pbw_solid_boundary_free when done */
    size_t facet_count, edge_count, hole_count;
    const pbw_index *facets;               /* 3 points each, turned out of the region that sides[0] is */
    const pbw_index *corners;              /* per facet: 4 t + i, the place of the corner across in mesh.corners */
    const pbw_index *patches;              /* per facet: the input's number, or a number of the patches that sharp
                                              edges bound; PBW_NONE: it closes a hole */
    const pbw_index *parts;                /* per facet: a number of the parts that sharp edges and borders of the
                                              input's patches bound; PBW_NONE: an open surface is far */
    const pbw_index *sides;                /* 2 a facet: the regions on both sides, the second PBW_NONE outside */
    const pbw_index *edges;                /* 2 points each: edges of facets on sharp edges, and between patches */
    const pbw_solid_hole *holes;           /* the largest first */
    void *memory;                          /* private */
} pbw_solid_boundary;

typedef struct pbw_solid_report {
    size_t open_edges, crowded_edges;      /* of the input: of one triangle, of more than two */
    size_t doubles;                        /* of the input: triangles with the corners of an earlier one, left out */
    size_t shells, holes;                  /* of the input: parts that edges of two triangles join; loops of open
                                              edges */
    pbw_solid_hole hole[PBW_SOLID_PLACES]; /* the largest of those */
    double hole_share;                     /* area of the triangles that close holes, by that of the others */
    double thickness;                      /* twice the input's volume by its area, in sizes; of a plate, how thick */
    double estimate;                       /* tetrahedra, known before the first point is; within a factor of 2 */
    size_t crossings;                      /* of the input: pairs of triangles that meet elsewhere than in common
                                              corners and edges, as pbw_surface_crossings finds them */
    double crossing_place[3];              /* where the first pair meets */
    size_t closing_crossings;              /* pairs besides, with a triangle that closes a hole */
    int united;                            /* 1: shells that cross were made one surface, the boundary of their union:
                                              input_volume and input_euler are its own */
    int refusal;                           /* PBW_SOLID_FILLED, or why there is no result */
    size_t regions;                        /* of the result */
    int sharp;                             /* which sharp edges were kept: PBW_SOLID_SHARP_ALL, SOME or NONE */
    double sharp_share;                    /* features by sharp edges, see there; -1: none were looked for */
    size_t corners, sharp_edges;           /* of the input, those that are kept */
    size_t acute_edges;                    /* of the input: sharp ones below 60 degrees, inside or outside; tetrahedra
                                              at them cannot have better dihedral angles than those */
    double least_angle;                    /* of the input's sharp edges, degrees, on the narrower side; 180: none */
    size_t missing_edges;                  /* pieces of sharp edges that are no edges of the mesh */
    size_t bad_edges, bad_points;          /* where the boundary is no manifold */
    double places[PBW_SOLID_PLACES][3];    /* the first of those */
    size_t facets;                         /* of the boundary */
    long euler, input_euler;               /* Euler numbers: of the boundary, of the input */
    double distance;                       /* Hausdorff distance of boundary and surface, sampled, in sizes; of the
                                              boundary from the surface alone if shells cross and are not united */
    double size;
    double input_volume;                   /* of shells that cross and are not united, the sum */
    int rounds, settled;                   /* settled: 1, nothing was left to add */
    double seconds[4];                     /* of processor time: sampling, rounds, improvement, this report */
    pbw_improve_report improve;
} pbw_solid_report;

/* Meshes a solid; how, options, boundary and report may be NULL.  mesh and boundary: overwritten, left empty on
   failure.  mesh.regions: the number of the innermost shell around each tetrahedron; shells are numbered in the order
   of their first triangles.  Returns PBW_DEGENERATE if nothing is inside or the surface is refused,
   PBW_ERROR_ARGUMENT for ids out of range or sizes below zero, PBW_ERROR_TOO_LARGE for a size that needs more than
   options.most tetrahedra, or what pbw_triangulate and pbw_improve fail with; report.refusal and the input's part of
   the report hold on failure, too. */
PBWDEF pbw_status pbw_solid(const pbw_solid_input *input, const pbw_solid_options *how,
                            const pbw_options *options, pbw_tets *mesh, pbw_solid_boundary *boundary,
                            pbw_solid_report *report);
PBWDEF void pbw_solid_boundary_free(pbw_solid_boundary *boundary);      /* fine on {0}, fine twice */

#ifdef __cplusplus
}
#endif
#endif /* PBW_MESH3_H */

#if defined(PBW_MESH3_IMPLEMENTATION) && !defined(PBWMESH3__IMPLEMENTED)
#define PBWMESH3__IMPLEMENTED
#if PBWSF__SEAM != 1
#error "pbw_mesh3.h is compiled where pbw_surface.h of its version is: define PBW_SURFACE_IMPLEMENTATION, too"
#elif PBWIM__SEAM != 1
#error "pbw_mesh3.h is compiled where pbw_improve.h of its version is: define PBW_IMPROVE_IMPLEMENTATION, too"
#else

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

PBW_CONTRACTION_OFF                        /* fused operations would give other coordinates */

/* ------------------------------------------------------------------------------------------------------
   >>work         The work in progress: progress, memory, local sizes, points in a grid.
   Holds: kind[p] says what point p is on; pieces are the parts of sharp chains between neighbouring samples; label[t]
   is 0 for tetrahedra outside; each point is in the list of its cell of the spacing grid.
   ------------------------------------------------------------------------------------------------------ */
/* Tip: on a smooth part, where without it the surface would be far from the boundary.  Removed: on another point. */
enum { PBWM3__SHARP, PBWM3__TIP, PBWM3__SMOOTH, PBWM3__INSIDE, PBWM3__REMOVED };
enum { PBWM3__BATCH = 8192 };              /* samples of the surface that threads compute at once */

typedef PBW_ARRAY(int) pbwm3__labels;

typedef struct pbwm3__new_point {          /* that a facet needs */
    double p[3];                           /* on the surface */
    size_t facet;                          /* 4 t + i */
    pbw_index inside;                      /* a corner of the facet that is a point inside, or PBW_NONE */
    pbw_index patch;                       /* of p */
} pbwm3__new_point;

typedef struct pbwm3__piece { pbw_index a, b; size_t chain; double from, to; } pbwm3__piece;  /* lengths along it */
typedef struct pbwm3__chain { size_t first, count, set; int closed, loose; } pbwm3__chain;    /* range of `path`;
                                              loose: an end of it is no other chain's; set: of its patches */
typedef struct pbwm3__chain_vertex { pbw_index vertex; double along; } pbwm3__chain_vertex;

typedef struct pbwm3__set { size_t first, count; } pbwm3__set;       /* range of `members` */

typedef struct pbwm3__shell {
    double volume, area;                   /* volume: signed until all are turned outward */
    size_t around;                         /* shells that it is inside of */
    size_t body;                           /* shells of one body have walls in common; without walls, itself */
    pbw_index triangle;                    /* its first */
    int open, seen;
} pbwm3__shell;

typedef struct pbwm3__points {             /* what a round starts from */
    pbwsf__vectors x;
    pbwsf__flags kind;
    pbwsf__indices set;
    PBW_ARRAY(pbwm3__piece) pieces;
    size_t faults, missing_edges;          /* of their boundary */
} pbwm3__points;

typedef struct pbwm3__triangulation {      /* of the points of a round */
    pbw_mesh mesh;
    pbwsf__vectors centre;                 /* of the sphere of each tetrahedron */
    pbwm3__labels label;
    pbwsf__flags needs;                    /* per tetrahedron, bits of the facets that need a point */
} pbwm3__triangulation;

typedef struct pbwm3__work {
    pbw_memory memory;
    const pbw_solid_input *input;
    pbw_solid_options how;
    int open;                              /* 1: not all holes of the input are closed: inside by winding number */
    double closing_area;                   /* area of the triangles that close holes */
    int nested;
    int twisted;                           /* 1: a shell has no two sides, as a Klein bottle */
    int joined;                            /* 1: triangles cross, and inside is where the winding number is above 0 */
    int walls;                             /* 1: a complex of walls between regions: edges of more than two triangles,
                                              or triangles given twice, and no open edges */
    int whole;                             /* 1: the surface is one patch, whatever its edges */
    int sharp;                             /* which sharp edges are kept */
    const pbw_options *caller;
    pbw_options options;                   /* the caller's, less what does not concern parts */
    double deadline;                       /* the processor time by which the work ends with what it has */
    double from, to;                       /* progress: the present stage's part of 0 to 1 */
    double begin, end;                     /* and the part of this attempt in all */
    double done;                           /* what was reported last */
    int timed, late, cancelled;            /* timed: the stage ends at the deadline; late: it has; cancelled: by the
                                              caller */
    double size, distance, cosine, low[3], high[3];
    double floor, gap_floor, finest;       /* what no size is below at first; between two shells; at tips */
    double least, mean, step;              /* the least size of the field, the mean of the surface's area; width of
                                              the spacing grid's cells */
    pbwsf__numbers field;                  /* local sizes, in cells as wide as the size, n along each axis */
    pbwsf__flags halved;                   /* per cell: which time its size was halved last */
    int halvings;                          /* how often rounds have halved sizes */
    size_t cells_halved;                   /* the last time */
    pbwm3__points kept;                    /* before the first time */
    size_t n[3];
    pbw_surface surface;                   /* of points at different places */
    pbwsf__vectors vertices;               /* its own arrays */
    pbwsf__triples triangles;
    pbwsf__vectors x;                      /* points of the mesh */
    pbwsf__flags kind;
    size_t first_closing;                  /* triangles from here on close holes */
    pbwsf__indices origin;                 /* of each triangle of the surface: its number in the input */
    pbwsf__indices shell;                  /* of each triangle */
    PBW_ARRAY(pbwm3__shell) shells;
    pbwsf__indices sides;                  /* with walls: per triangle, the shells in front of it and behind it */
    pbwsf__indices outer;                  /* with walls: per triangle, the shell around its body, PBW_NONE outside
                                              all; before it is known, the body's number */
    PBW_ARRAY(pbw_solid_hole) holes;
    pbwsf__pairs crossing;                 /* where shells are joined: pairs of triangles that meet */
    pbwsf__numbers segments;               /* 6 a pair: what they have in common */
    pbwsf__vectors planes;                 /* where shells are united: per triangle, the normal of that which it is a
                                              piece of */
    pbwsf__pairs cuts;                     /* and the edges where they cross, sorted */
    pbwsf__indices part;                   /* of each triangle: its part of the surface between sharp edges */
    pbwsf__indices patch;                  /* the same, or 0 if the surface is one patch */
    pbwsf__indices firsts;                 /* the first triangle of each patch */
    PBW_ARRAY(pbwm3__set) sets;
    pbwsf__indices members;                /* sets of patches: set i < patch_count is {i}, others are those that
                                              meet at sharp edges and corners */
    pbwsf__indices set;                    /* of each point: the set of patches that it is on */
    size_t patch_count;
    pbwsf__indices heads, links;           /* spacing grid: the first point of each cell, the next in its cell */
    size_t cells;
    PBW_ARRAY(pbwm3__piece) pieces;
    PBW_ARRAY(pbwm3__chain) chains;
    PBW_ARRAY(pbwm3__chain_vertex) path;
    pbwm3__triangulation now, last;        /* that of the round before, while it tells something */
    pbwsf__flags moved;                    /* per point: 1, it was changed since the last one */
    pbwsf__indices same;                   /* per tetrahedron: its number in the last one, PBW_NONE if it is new */
    PBW_ARRAY(pbwm3__new_point) new_points;
    pbwsf__quadruples corners;             /* the solid before improvement */
    pbwsf__indices regions;
    pbwsf__flags marks;
    pbw_solid_report *report;
} pbwm3__work;

/* Puts an item behind the last that is an array itself; item: its address.  Returns 0 without memory. */
#define PBWM3__APPEND(w, array, item) (PBW_RESERVE(&(w)->memory, array, 1) \
                                       && (memcpy((array).at + (array).count++, item, sizeof *(array).at), 1))

static int pbwm3__is_late(const pbwm3__work *w)
{
    return w->deadline < HUGE_VAL && (double)clock() / CLOCKS_PER_SEC > w->deadline;
}

static int pbwm3__has_ended(const pbwm3__work *w)
{
    return w->cancelled || (w->timed && w->late);
}

/* Reports the progress once more, within a share of it.  Returns 1 if the caller cancels, or the time of the stage is
   over. */
static int pbwm3__ends(pbwm3__work *w)
{
    w->late |= w->timed && pbwm3__is_late(w);
    w->cancelled |= w->caller != NULL && w->caller->progress != NULL
                 && w->caller->progress(w->caller->progress_user, PBW_STAGE_WORK, w->done) != 0;
    return pbwm3__has_ended(w);
}

/* The same within a loop: only for some of its items. */
static int pbwm3__ends_at(pbwm3__work *w, size_t i, size_t step)
{
    return i % step == step - 1 && pbwm3__ends(w);
}

/* Reports that a share of the current stage is done.  Returns as pbwm3__ends does. */
static int pbwm3__progress(pbwm3__work *w, double share)
{
    w->done = w->begin + (w->end - w->begin) * (w->from + (w->to - w->from) * share);
    return pbwm3__ends(w);
}

/* Progress of a call that is within a share. */
static int pbwm3__inner_progress(void *user, pbw_stage stage, double done)
{
    (void)stage;
    (void)done;
    return pbwm3__ends((pbwm3__work *)user);
}

/* Begins a stage, which ends at `to` of the progress.  Returns as pbwm3__ends does. */
static int pbwm3__begin_stage(pbwm3__work *w, const char *stage, double to)
{
    w->from = w->to;
    w->to = to;
    if (w->how.stage != NULL) {
        *w->how.stage = stage;
    }
    return pbwm3__progress(w, 0);
}

/* Returns why sampling must end: the caller cancels, the time is over, or there are too many points; PBW_OK if none.
   A point makes about five tetrahedra. */
static pbw_status pbwm3__check_budget(pbwm3__work *w, double share)
{
    const double tets = 5 * (double)w->x.count;
    if (tets > (w->how.most > 0 ? w->how.most : 5e7)) {
        w->report->refusal = PBW_SOLID_LARGE;
        w->report->estimate = fmax(tets, w->report->estimate);
        return PBW_ERROR_TOO_LARGE;
    }
    return pbwm3__progress(w, share) ? PBW_CANCELLED : PBW_OK;
}

/* Returns the options for a call of the library: their memory limit is the caller's less the bytes held. */
static const pbw_options *pbwm3__inner_options(pbwm3__work *w)
{
    w->options.memory_limit = pbw_memory_left(&w->memory);
    w->options.progress = pbwm3__inner_progress;
    w->options.progress_user = w;
    return &w->options;
}

/* A loop on all threads.  Returns 0 if there is no memory, or the work must end. */
static int pbwm3__for(pbwm3__work *w, size_t count, size_t grain, pbw_body *body, void *arg)
{
    return pbw_for(pbwm3__inner_options(w), count, grain, body, arg) == PBW_OK;
}

/* Returns the status of a stage: what returns 0 without memory does so, too, where the work must end. */
static pbw_status pbwm3__status_of(const pbwm3__work *w, pbw_status status)
{
    return status == PBW_ERROR_MEMORY && pbwm3__has_ended(w) ? PBW_CANCELLED : status;
}

/* ---- lists that threads make, in order: each item gives some entries, which are counted, then written ---- */

enum { PBWM3__SLICE = 4096 };              /* items of one range */
#define PBWM3__COUNTS ((size_t)-1)

/* Writes the entries of an item, from number `at` on, unless that is PBWM3__COUNTS.  Returns how many it has. */
typedef size_t pbwm3__lister(void *lists, size_t item, size_t at);

typedef struct pbwm3__listing {
    pbwm3__lister *lister;
    void *lists;                           /* what the lister needs */
    size_t items;
    pbwsf__counts first;                   /* per slice: how many entries it has, then the number of its first */
    int writes;
} pbwm3__listing;

static pbw_status pbwm3__list_range(void *arg, size_t from, size_t to)
{
    const pbwm3__listing *l = (const pbwm3__listing *)arg;
    size_t *first = l->first.at + from / PBWM3__SLICE, sum = 0;
    for (; from < to; from++) {
        sum += l->lister(l->lists, from, l->writes ? *first + sum : PBWM3__COUNTS);
    }
    *first = l->writes ? *first : sum;
    return PBW_OK;
}

/* Counts the entries.  Returns 0 if there is no memory; *total: how many. */
static int pbwm3__count_list(pbwm3__work *w, size_t items, pbwm3__lister *lister, void *lists, pbwm3__listing *l,
                             size_t *total)
{
    size_t i, sum = 0;
    memset(l, 0, sizeof *l);
    l->lister = lister;
    l->lists = lists;
    l->items = items;
    if (!PBW_ZEROS(&w->memory, l->first, items / PBWM3__SLICE + 1)
        || !pbwm3__for(w, items, PBWM3__SLICE, pbwm3__list_range, l)) {
        return 0;
    }
    for (i = 0; i < l->first.count; i++) {
        const size_t here = l->first.at[i];
        l->first.at[i] = sum;
        sum += here;
    }
    l->writes = 1;
    *total = sum;
    return 1;
}

/* Writes the entries, if there is room for them, and ends the list.  Returns 0 if not. */
static int pbwm3__write_list(pbwm3__work *w, pbwm3__listing *l, int room)
{
    const int good = room && pbwm3__for(w, l->items, PBWM3__SLICE, pbwm3__list_range, l);
    PBW_RELEASE(&w->memory, l->first);
    return good;
}

/* Makes a surface, which counts as held until it is dropped. */
static pbw_status pbwm3__make_surface(pbwm3__work *w, const double *points, size_t point_count,
                                      const pbw_index *triangles, size_t triangle_count, pbw_surface *surface)
{
    pbw_status status = pbw_surface_create(points, point_count, triangles, triangle_count, pbwm3__inner_options(w),
                                           surface);
    status = status == PBW_OK && w->open ? pbwsf__find_open(surface, &w->options) : status;
    w->memory.used += pbwsf__bytes(surface);
    return status;
}

static void pbwm3__drop_surface(pbwm3__work *w, pbw_surface *surface)
{
    w->memory.used -= pbwsf__bytes(surface);
    pbw_surface_free(surface);
}

/* The bytes of a mesh that borrows its points: corners, links, incident, canonical, and 1024 for small parts. */
static size_t pbwm3__mesh_bytes(const pbw_mesh *mesh)
{
    return mesh->memory == NULL ? 0 : 8 * mesh->simplex_count * sizeof(pbw_index)
                                      + 2 * mesh->point_count * sizeof(pbw_index) + 1024;
}

static void pbwm3__drop_mesh(pbwm3__work *w, pbw_mesh *mesh)
{
    w->memory.used -= pbwm3__mesh_bytes(mesh);
    pbw_free(mesh);
}

static void pbwm3__drop_triangulation(pbwm3__work *w, pbwm3__triangulation *of)
{
    pbwm3__drop_mesh(w, &of->mesh);
    PBW_RELEASE(&w->memory, of->centre);
    PBW_RELEASE(&w->memory, of->label);
    PBW_RELEASE(&w->memory, of->needs);
}

/* Reports the progress of a call that is the current stage. */
static int pbwm3__part_progress(void *user, pbw_stage stage, double done)
{
    (void)stage;
    return pbwm3__progress((pbwm3__work *)user, done);
}

/* The field's cell that p is in, or nearest to. */
static size_t pbwm3__field_cell(const pbwm3__work *w, const double p[3])
{
    size_t at[3];
    int k;
    for (k = 0; k < 3; k++) {
        const double x = (p[k] - w->low[k]) / w->size;
        at[k] = !(x > 0) ? 0 : x < (double)w->n[k] ? (size_t)x : w->n[k] - 1;
    }
    return at[0] + w->n[0] * (at[1] + w->n[1] * at[2]);
}

static double pbwm3__size(const pbwm3__work *w, const double p[3])
{
    const double size = w->least < w->size ? w->field.at[pbwm3__field_cell(w, p)] : w->size;
    return w->how.size_at == NULL ? size : fmax(w->least, fmin(size, w->how.size_at(w->how.size_user, p)));
}

/* ---- the spacing grid: a hash table of cells ---- */

static size_t pbwm3__cell(const pbwm3__work *w, const int64_t at[3])
{
    uint64_t key = (uint64_t)at[0] * 0x9e3779b97f4a7c15u ^ (uint64_t)at[1] * 0xbf58476d1ce4e5b9u
                 ^ (uint64_t)at[2] * 0x94d049bb133111ebu;
    key ^= key >> 29;
    return (size_t)(key * 0x9e3779b97f4a7c15u >> 20) & (w->cells - 1);
}

static size_t pbwm3__cell_of(const pbwm3__work *w, const double p[3])
{
    int64_t at[3];
    int k;
    for (k = 0; k < 3; k++) {
        at[k] = (int64_t)floor((p[k] - w->low[k]) / w->step);
    }
    return pbwm3__cell(w, at);
}

/* The nearest point to p of kinds `least` to `most` within a distance; PBW_NONE if there is none. */
static pbw_index pbwm3__nearest(const pbwm3__work *w, const double p[3], double within, int least, int most)
{
    const pbw_index *heads = w->heads.at, *links = w->links.at;
    const unsigned char *kinds = w->kind.at;
    double best = within;
    pbw_index found = PBW_NONE, q;
    int64_t low[3], high[3], at[3];
    int k;
    for (k = 0; k < 3; k++) {
        low[k] = (int64_t)floor((p[k] - within - w->low[k]) / w->step);
        high[k] = (int64_t)floor((p[k] + within - w->low[k]) / w->step);
    }
    for (at[2] = low[2]; at[2] <= high[2]; at[2]++) {
        for (at[1] = low[1]; at[1] <= high[1]; at[1]++) {
            for (at[0] = low[0]; at[0] <= high[0]; at[0]++) {
                for (q = heads[pbwm3__cell(w, at)]; q != PBW_NONE; q = links[q]) {
                    const double d = kinds[q] < least || kinds[q] > most ? HUGE_VAL
                                   : pbwsf__distance(p, w->x.at[q]);
                    if (d < best || (d <= best && q < found && found != PBW_NONE)) {
                        best = d;
                        found = q;
                    }
                }
            }
        }
    }
    return found;
}

/* Returns whether one of these is nearer to p than a distance: where most are, in its own cell, is looked first. */
static int pbwm3__has_near(const pbwm3__work *w, const double p[3], double within, int least, int most)
{
    const unsigned char *kinds = w->kind.at;
    pbw_index q = w->heads.at[pbwm3__cell_of(w, p)];
    while (q != PBW_NONE && !(kinds[q] >= least && kinds[q] <= most && pbwsf__distance(p, w->x.at[q]) < within)) {
        q = w->links.at[q];
    }
    return q != PBW_NONE || pbwm3__nearest(w, p, within, least, most) != PBW_NONE;
}

static void pbwm3__put_in_cell(pbwm3__work *w, pbw_index p)
{
    pbw_index *head = w->heads.at + pbwm3__cell_of(w, w->x.at[p]);
    w->links.at[p] = *head;
    *head = p;
}

static void pbwm3__take_from_cell(pbwm3__work *w, pbw_index p)
{
    pbw_index *link = w->heads.at + pbwm3__cell_of(w, w->x.at[p]);
    while (*link != p) {
        link = w->links.at + *link;
    }
    *link = w->links.at[p];
}

/* A new point on the patches of a set.  Returns its number, or PBW_NONE if there is no memory. */
static pbw_index pbwm3__add(pbwm3__work *w, const double p[3], int kind, size_t set)
{
    const pbw_index number = (pbw_index)w->x.count;
    const unsigned char byte = (unsigned char)kind;
    const pbw_index on = (pbw_index)set;
    if (w->x.count >= PBW_NONE / 8 || !PBW_RESERVE(&w->memory, w->links, 1) || !PBW_RESERVE(&w->memory, w->kind, 1)
        || !PBW_RESERVE(&w->memory, w->moved, 1) || !PBW_PUSH(&w->memory, w->set, on)
        || !PBWM3__APPEND(w, w->x, p)) {
        return PBW_NONE;
    }
    w->links.count++;
    w->moved.at[w->moved.count++] = 1;
    w->kind.at[w->kind.count++] = byte;
    pbwm3__put_in_cell(w, number);
    return number;
}

/* ------------------------------------------------------------------------------------------------------
   >>input        The input's surface, and its edges.
   In: triangles; or an implicit function.  Out: `vertices` at different places, and `triangles` of them without a
   corner twice; of any triangles, their edges sorted.
   ------------------------------------------------------------------------------------------------------ */
static int pbwm3__weld(pbwm3__work *w, const pbw_solid_input *in, const pbw_index *order, pbw_index *number)
{
    size_t i;
    for (i = 0; i < in->point_count; i++) {
        number[i] = PBW_NONE;
    }
    for (i = 0; i < 3 * in->triangle_count; i++) {
        number[in->triangles[i]] = 0;                /* it is used */
    }
    for (i = 0; i < in->point_count; i++) {
        const double *p = in->points + 3 * (size_t)order[i];
        const double *last = w->vertices.count == 0 ? p : w->vertices.at[w->vertices.count - 1];
        if (number[order[i]] == PBW_NONE) {
            continue;
        }
        if (w->vertices.count == 0 || p[0] < last[0] || p[0] > last[0] || p[1] < last[1] || p[1] > last[1]
            || p[2] < last[2] || p[2] > last[2]) {
            if (!PBWM3__APPEND(w, w->vertices, p)) {
                return 0;
            }
        }
        number[order[i]] = (pbw_index)(w->vertices.count - 1);
    }
    for (i = 0; i < in->triangle_count; i++) {
        pbw_index t[3];
        int k;
        for (k = 0; k < 3; k++) {
            t[k] = number[in->triangles[3 * i + (size_t)k]];
        }
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) {
            const pbw_index from = (pbw_index)i;
            if (!PBWM3__APPEND(w, w->triangles, t) || !PBW_PUSH(&w->memory, w->origin, from)) {
                return 0;
            }
        }
    }
    return 1;
}

static pbw_status pbwm3__take_triangles(pbwm3__work *w, const pbw_solid_input *in)
{
    pbwsf__indices order = { NULL, 0, 0 }, number = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i;
    for (i = 0; i < 3 * in->triangle_count; i++) {
        if (in->triangles[i] >= in->point_count) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    if (PBW_FIT(&w->memory, order, in->point_count + 1)
        && PBW_FIT(&w->memory, number, in->point_count + 1)) {
        status = pbw_order(3, in->points, in->point_count, pbwm3__inner_options(w), order.at);
        if ((status == PBW_OK || status == PBW_DEGENERATE)
            && !pbwm3__weld(w, in, order.at, number.at)) {
            status = PBW_ERROR_MEMORY;
        }
    }
    PBW_RELEASE(&w->memory, order);
    PBW_RELEASE(&w->memory, number);
    return status;
}

/* ---- an implicit function, over the six tetrahedra of each cube of a grid ---- */

typedef size_t pbwm3__nodes[2];

/* A cube that the surface crosses.  Each of its edges belongs to the lowest cube that has it. */
typedef struct pbwm3__cube {
    size_t node;                           /* its first one */
    pbw_index vertices, triangles;         /* how many are its own; then the numbers of the first ones */
} pbwm3__cube;

enum { PBWM3__EDGES = 27 };                /* room for the 19 edges of a cube: pbwm3__edge_of */

typedef struct pbwm3__grid {
    pbwm3__work *w;
    size_t n[3];                           /* nodes along the axes */
    double step;
    pbwsf__numbers value;                  /* per node */
    pbwsf__indices crossed;                /* per node: the number of the cube that it is the first of, or PBW_NONE */
    PBW_ARRAY(pbwm3__cube) cube;
    pbwsf__indices number;                 /* per cube and edge: of the vertex there, among those of the cube */
    PBW_ARRAY(pbwm3__nodes) ends;          /* of each vertex: the nodes of its edge, that below zero first */
    int writes;                            /* 0: vertices and triangles are counted */
} pbwm3__grid;

typedef struct pbwm3__march {              /* through one cube */
    pbwm3__grid *g;
    size_t cube;
    int low;                               /* bits of the axes along which there is no cube before it */
    pbw_index vertices, triangles;         /* so far */
} pbwm3__march;

static void pbwm3__node(const pbwm3__work *w, const pbwm3__grid *g, size_t node, double p[3])
{
    p[0] = w->low[0] + g->step * (double)(node % g->n[0]);
    p[1] = w->low[1] + g->step * (double)(node / g->n[0] % g->n[1]);
    p[2] = w->low[2] + g->step * (double)(node / g->n[0] / g->n[1]);
}

/* Where the function is zero between a, where it is below zero, and b: by halving, up to rounding of the step. */
static void pbwm3__root(const pbw_solid_input *in, const double a[3], const double b[3], double out[3])
{
    double from = 0, to = 1;
    int i;
    for (i = 0; i < 40; i++) {
        pbwsf__between(a, b, (from + to) / 2, out);
        *(in->value(in->value_user, out) < 0 ? &from : &to) = (from + to) / 2;
    }
}

/* Corner i of the cube that a node is the first of. */
static size_t pbwm3__cube_corner(const pbwm3__grid *g, size_t node, int i)
{
    return node + (size_t)(i & 1) + (size_t)(i >> 1 & 1) * g->n[0] + (size_t)(i >> 2) * g->n[0] * g->n[1];
}

/* The number of an edge of a cube, from corner i: a digit 0, 1 or 2 for each axis, 2 where the edge runs along it. */
static size_t pbwm3__edge_of(int i, int direction)
{
    static const size_t digits[8] = { 0, 1, 3, 4, 9, 10, 12, 13 };
    return digits[i] + 2 * digits[direction];
}

/* The vertex on the edge between two corners of the cube, the first of them below zero. */
static pbw_index pbwm3__cross_edge(pbwm3__march *m, int in, int out)
{
    const pbwm3__grid *g = m->g;
    const size_t node = g->cube.at[m->cube].node;
    const int direction = in ^ out, from = in & out, back = 7 & ~(direction | from | m->low);
    const size_t owner = back == 0 ? m->cube : g->crossed.at[node - pbwm3__cube_corner(g, 0, back)];
    pbw_index *number = g->number.at + PBWM3__EDGES * owner + pbwm3__edge_of(from | back, direction), vertex;
    if (!g->writes) {
        if (back == 0 && *number == PBW_NONE) {
            *number = m->vertices++;
        }
        return 0;
    }
    vertex = g->cube.at[owner].vertices + *number;
    if (back == 0) {
        g->ends.at[vertex][0] = pbwm3__cube_corner(g, node, in);
        g->ends.at[vertex][1] = pbwm3__cube_corner(g, node, out);
    }
    return vertex;
}

/* Makes the triangles of one tetrahedron, by its corners of the cube. */
static void pbwm3__cross_tet(pbwm3__march *m, const int corner[4])
{
    const pbwm3__grid *g = m->g;
    const pbwm3__cube *cube = g->cube.at + m->cube;
    pbw_index v[4], *t;
    int in[4], out[4], ins = 0, outs = 0, count = 0, i, k;
    for (i = 0; i < 4; i++) {
        if (g->value.at[pbwm3__cube_corner(g, cube->node, corner[i])] < 0) {
            in[ins++] = corner[i];
        } else {
            out[outs++] = corner[i];
        }
    }
    for (i = 0; i < ins; i++) {                      /* in turn around the quadrilateral of two and two */
        for (k = 0; k < outs; k++) {
            v[count++] = pbwm3__cross_edge(m, in[i], out[ins == 2 && i == 1 ? 1 - k : k]);
        }
    }
    for (i = 2; i < count; i++, m->triangles++) {
        if (g->writes) {
            t = g->w->triangles.at[cube->triangles + m->triangles];
            t[0] = v[0], t[1] = v[i - 1], t[2] = v[i];
        }
    }
}

/* Counts the vertices and triangles of cubes, or writes them. */
static pbw_status pbwm3__cross_range(void *arg, size_t from, size_t to)
{
    static const int path[6][4] = { { 0, 1, 3, 7 }, { 0, 1, 5, 7 }, { 0, 2, 3, 7 }, { 0, 2, 6, 7 }, { 0, 4, 5, 7 },
                                    { 0, 4, 6, 7 } };
    pbwm3__grid *g = (pbwm3__grid *)arg;
    int i;
    for (; from < to; from++) {
        pbwm3__cube *cube = g->cube.at + from;
        pbwm3__march m = { g, from, 0, 0, 0 };
        m.low = (cube->node % g->n[0] == 0) + 2 * (cube->node / g->n[0] % g->n[1] == 0)
              + 4 * (cube->node < g->n[0] * g->n[1]);
        if (!g->writes) {
            memset(g->number.at + PBWM3__EDGES * from, 0xff, PBWM3__EDGES * sizeof *g->number.at);
        }
        for (i = 0; i < 6; i++) {
            pbwm3__cross_tet(&m, path[i]);
        }
        if (!g->writes) {
            cube->vertices = m.vertices;
            cube->triangles = m.triangles;
        }
    }
    return PBW_OK;
}

static pbw_status pbwm3__value_range(void *arg, size_t from, size_t to)
{
    const pbwm3__grid *g = (const pbwm3__grid *)arg;
    const pbw_solid_input *in = g->w->input;
    size_t i;
    for (i = from; i < to; i++) {
        double p[3];
        pbwm3__node(g->w, g, i, p);
        g->value.at[i] = in->value(in->value_user, p);
    }
    return PBW_OK;
}

/* Lists the cube of a node if its corners are on both sides of zero. */
static size_t pbwm3__list_cube(void *lists, size_t node, size_t at)
{
    const pbwm3__grid *g = (const pbwm3__grid *)lists;
    const double *value = g->value.at + node;
    const size_t row = g->n[0], layer = g->n[0] * g->n[1];
    size_t below, crossed;
    if (node + layer + row + 1 >= layer * g->n[2]) {
        below = 0;
    } else {
        below = (size_t)(value[0] < 0) + (size_t)(value[1] < 0) + (size_t)(value[row] < 0)
              + (size_t)(value[row + 1] < 0) + (size_t)(value[layer] < 0) + (size_t)(value[layer + 1] < 0)
              + (size_t)(value[layer + row] < 0) + (size_t)(value[layer + row + 1] < 0);
    }
    crossed = below % 8 != 0 && node % row + 1 < row && node / row % g->n[1] + 1 < g->n[1];
    if (at != PBWM3__COUNTS) {
        g->crossed.at[node] = crossed ? (pbw_index)at : PBW_NONE;
        if (crossed) {
            g->cube.at[at].node = node;
        }
    }
    return crossed;
}

static pbw_status pbwm3__root_range(void *arg, size_t from, size_t to)
{
    const pbwm3__grid *g = (const pbwm3__grid *)arg;
    size_t i;
    for (i = from; i < to; i++) {
        const size_t *ends = g->ends.at[i];
        double p[3], q[3];
        pbwm3__node(g->w, g, ends[0], p);
        pbwm3__node(g->w, g, ends[1], q);
        pbwm3__root(g->w->input, p, q, g->w->vertices.at[i]);
    }
    return PBW_OK;
}

/* Makes the triangles, with edges of the grid as corners. */
static int pbwm3__cross_cubes(pbwm3__work *w, pbwm3__grid *g, size_t nodes)
{
    pbwm3__listing listing;
    size_t cubes, vertices = 0, triangles = 0, i;
    if (!pbwm3__count_list(w, nodes, pbwm3__list_cube, g, &listing, &cubes)
        || !pbwm3__write_list(w, &listing, PBW_FIT(&w->memory, g->cube, cubes + 1)
                                           && PBW_FIT(&w->memory, g->number, PBWM3__EDGES * (cubes + 1)))
        || !pbwm3__for(w, cubes, 256, pbwm3__cross_range, g)) {
        return 0;
    }
    for (i = 0; i < cubes; i++) {
        pbwm3__cube *cube = g->cube.at + i;
        const size_t here[2] = { cube->vertices, cube->triangles };
        cube->vertices = (pbw_index)vertices;
        cube->triangles = (pbw_index)triangles;
        vertices += here[0];
        triangles += here[1];
        if (vertices >= PBW_NONE / 8) {
            return 0;
        }
    }
    g->writes = 1;
    if (!PBW_FIT(&w->memory, g->ends, vertices + 1) || !PBW_FIT(&w->memory, w->triangles, triangles + 1)) {
        return 0;
    }
    g->ends.count = vertices;
    w->triangles.count = triangles;
    return pbwm3__for(w, cubes, 256, pbwm3__cross_range, g);
}

/* Makes the triangles; then threads find the places of their corners. */
static pbw_status pbwm3__take_function(pbwm3__work *w)
{
    pbwm3__grid g;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t nodes = 1;
    int k;
    memset(&g, 0, sizeof g);
    g.w = w;
    g.step = fmax(w->size / 2, pbwsf__distance(w->low, w->high) / 400);
    for (k = 0; k < 3; k++) {
        g.n[k] = (size_t)ceil((w->high[k] - w->low[k]) / g.step) + 1;
        nodes *= g.n[k];
    }
    if (PBW_FIT(&w->memory, g.value, nodes) && PBW_FIT(&w->memory, g.crossed, nodes)) {
        status = pbw_for(pbwm3__inner_options(w), nodes, 1024, pbwm3__value_range, &g);
        status = status == PBW_OK && !pbwm3__cross_cubes(w, &g, nodes) ? PBW_ERROR_MEMORY : status;
    }
    if (status == PBW_OK && !PBW_FIT(&w->memory, w->vertices, g.ends.count + 1)) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        w->vertices.count = g.ends.count;
        status = pbw_for(pbwm3__inner_options(w), g.ends.count, 128, pbwm3__root_range, &g);
    }
    PBW_RELEASE(&w->memory, g.value);
    PBW_RELEASE(&w->memory, g.crossed);
    PBW_RELEASE(&w->memory, g.cube);
    PBW_RELEASE(&w->memory, g.number);
    PBW_RELEASE(&w->memory, g.ends);
    return status;
}

typedef struct pbwm3__edging { const pbw_index *triangles; pbwim__facet *edge; } pbwm3__edging;

static pbw_status pbwm3__edge_range(void *arg, size_t from, size_t to)
{
    const pbwm3__edging *edging = (const pbwm3__edging *)arg;
    const pbw_index *triangles = edging->triangles;
    for (; from < to; from++) {
        const pbw_index a = triangles[from], b = triangles[from / 3 * 3 + (from + 1) % 3];
        pbwim__facet *edge = edging->edge + from;
        edge->v[0] = a < b ? a : b;
        edge->v[1] = a < b ? b : a;
        edge->v[2] = a < b;
        edge->t = (pbw_index)(from / 3);
        edge->i = (int)(from % 3);
    }
    return PBW_OK;
}

/* Returns edges, sorted: v[0] < v[1], v[2] whether the triangle t has them upwards, i its corner that starts it.
   NULL: no memory, or the work must end. */
static pbwim__facet *pbwm3__edges(pbwm3__work *w, const pbw_index *triangles, size_t count, size_t points,
                                  pbwim__sorting *sorting)
{
    pbwm3__edging edging;
    memset(sorting, 0, sizeof *sorting);
    if (!pbwim__begin_sorting(&w->memory, sorting, 3 * count, points)) {
        return NULL;
    }
    edging.triangles = triangles;
    edging.edge = sorting->items.at;
    return pbwm3__for(w, 3 * count, PBWM3__SLICE, pbwm3__edge_range, &edging)
         ? pbwim__sort(pbwm3__inner_options(w), sorting, 3 * count, 2) : NULL;
}

/* Starts union-find trees of single items. */
static int pbwm3__start_trees(pbw_memory *memory, pbwsf__counts *parents, size_t count)
{
    size_t i;
    if (!PBW_FIT(memory, *parents, count + 1)) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        parents->at[i] = i;
    }
    return 1;
}

static size_t pbwm3__root_of(size_t *parent, size_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

/* Joins the trees of a and b: a root is the least of its tree. */
static void pbwm3__join(size_t *parent, size_t a, size_t b)
{
    a = pbwm3__root_of(parent, a);
    b = pbwm3__root_of(parent, b);
    parent[a < b ? b : a] = a < b ? a : b;
}

/* ------------------------------------------------------------------------------------------------------
   >>shells       Shells: triangles joined by edges with two triangles.
   In: triangles.  Out: `shells`, their triangles oriented alike, in closed ones outward; holes, listed and closed by
   triangles; with walls, the shells on both sides of each triangle.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwm3__orientation {        /* union-find trees of triangles */
    size_t *parent;
    unsigned char *flipped;                /* 1: oriented the other way than the parent */
} pbwm3__orientation;

/* Returns the root of i; *flipped: whether i is oriented the other way than the root. */
static size_t pbwm3__oriented_root(const pbwm3__orientation *trees, size_t i, int *flipped)
{
    *flipped = 0;
    while (trees->parent[i] != i) {
        const size_t up = trees->parent[i];
        trees->flipped[i] ^= trees->parent[up] != up ? trees->flipped[up] : 0;
        trees->parent[i] = trees->parent[up];
        *flipped ^= trees->flipped[i];
        i = trees->parent[i];
    }
    return i;
}

typedef struct pbwm3__open_edge { pbw_index a, b, triangle, next; } pbwm3__open_edge;    /* next: another from a */
typedef PBW_ARRAY(pbwm3__open_edge) pbwm3__open_edges;

/* Joins the triangles at edges of two, and lists the open edges, as their triangles have them. */
static int pbwm3__join_shells(pbwm3__work *w, const pbwm3__orientation *trees, pbwm3__open_edges *open)
{
    const size_t count = 3 * w->triangles.count;
    pbwim__sorting sorting;
    const pbwim__facet *edge = pbwm3__edges(w, (const pbw_index *)w->triangles.at, w->triangles.count,
                                            w->vertices.count, &sorting);
    size_t i, k;
    int good = edge != NULL;
    for (i = 0; good && i < count; i = k) {
        for (k = i + 1; k < count && memcmp(edge[i].v, edge[k].v, 2 * sizeof(pbw_index)) == 0; k++) {
        }
        w->report->crowded_edges += k - i > 2;
        if (k - i == 1) {
            const size_t at = edge[i].v[2] ? 0 : 1;
            pbwm3__open_edge e;
            e.a = edge[i].v[at];
            e.b = edge[i].v[1 - at];
            e.triangle = edge[i].t;
            e.next = PBW_NONE;
            w->report->open_edges++;
            good = PBW_PUSH(&w->memory, *open, e);
        } else if (k - i == 2) {
            int first, second;
            const size_t a = pbwm3__oriented_root(trees, edge[i].t, &first);
            const size_t b = pbwm3__oriented_root(trees, edge[i + 1].t, &second);
            if (a != b) {
                trees->parent[a < b ? b : a] = a < b ? a : b;
                trees->flipped[a < b ? b : a] = (unsigned char)(first ^ second
                                                                ^ (edge[i].v[2] == edge[i + 1].v[2]));
            } else {
                w->twisted |= (first ^ second) != (edge[i].v[2] == edge[i + 1].v[2]);
            }
        }
    }
    pbwim__end_sorting(&w->memory, &sorting);
    return good;
}

static void pbwm3__flip_triangle(pbwm3__work *w, size_t t)
{
    pbw_index *c = w->triangles.at[t];
    const pbw_index was = c[1];
    int k;
    c[1] = c[2];
    c[2] = was;
    for (k = 0; k < 3 && t < w->planes.count; k++) {
        w->planes.at[t][k] = -w->planes.at[t][k];
    }
}

/* Orients the triangles of each shell like the majority, and numbers the shells by their first triangles. */
static int pbwm3__number_shells(pbwm3__work *w, const pbwm3__orientation *trees)
{
    const size_t count = w->triangles.count;
    pbwm3__shell shell;
    pbw_index *number;
    size_t t;
    int flipped;
    memset(&shell, 0, sizeof shell);
    if (!PBW_FIT(&w->memory, w->shell, count + 1)) {
        return 0;
    }
    number = w->shell.at;
    for (t = 0; t < count; t++) {
        const size_t root = pbwm3__oriented_root(trees, t, &flipped);
        shell.triangle = (pbw_index)t;
        shell.body = w->shells.count;
        number[t] = root == t ? (pbw_index)w->shells.count : number[root];
        if (root == t && !PBW_PUSH(&w->memory, w->shells, shell)) {
            return 0;
        }
        w->shells.at[number[t]].volume += flipped ? -1 : 1;
    }
    for (t = 0; t < count; t++) {
        (void)pbwm3__oriented_root(trees, t, &flipped);
        if (flipped == (w->shells.at[number[t]].volume >= 0)) {
            pbwm3__flip_triangle(w, t);
        }
    }
    w->shell.count = count;
    w->report->shells = w->shells.count;
    return 1;
}

typedef struct pbwm3__moments { const pbwm3__work *w; double middle[3], *at; } pbwm3__moments;

/* The volume of each triangle with the middle of the box, and its area. */
static pbw_status pbwm3__moment_range(void *arg, size_t from, size_t to)
{
    const pbwm3__moments *moments = (const pbwm3__moments *)arg;
    for (; from < to; from++) {
        const pbw_index *c = moments->w->triangles.at[from];
        double p[3][3], n[3];
        int i, k;
        for (i = 0; i < 3; i++) {
            for (k = 0; k < 3; k++) {
                p[i][k] = moments->w->vertices.at[c[i]][k] - moments->middle[k];
            }
        }
        pbwsf__normal(p[0], p[1], p[2], n);
        moments->at[2 * from] = pbwsf__dot(p[0], n) / 6;
        moments->at[2 * from + 1] = sqrt(pbwsf__dot(n, n)) / 2;
    }
    return PBW_OK;
}

/* Areas and volumes of the shells; closed ones are turned outward.  Returns 0 if there is no memory. */
static int pbwm3__measure_shells(pbwm3__work *w)
{
    const pbw_index *number = w->shell.at;
    pbwm3__shell *shell = w->shells.at;
    pbwsf__numbers numbers = { NULL, 0, 0 };
    pbwm3__moments moments;
    size_t t;
    int good = PBW_FIT(&w->memory, numbers, 2 * w->triangles.count + 1);
    moments.w = w;
    moments.at = numbers.at;
    pbwsf__between(w->low, w->high, 0.5, moments.middle);
    good = good && pbwm3__for(w, w->triangles.count, 2048, pbwm3__moment_range, &moments);
    for (t = 0; t < w->shells.count && good; t++) {
        shell[t].volume = shell[t].area = 0;
    }
    for (t = 0; t < w->triangles.count && good; t++) {
        shell[number[t]].volume += numbers.at[2 * t];
        shell[number[t]].area += numbers.at[2 * t + 1];
    }
    for (t = 0; t < w->triangles.count && good; t++) {
        if (shell[number[t]].volume < 0 && !shell[number[t]].open) {
            pbwm3__flip_triangle(w, t);
        }
    }
    PBW_RELEASE(&w->memory, numbers);
    return good;
}

/* ---- holes ---- */

/* Triangles of least area between the n points of a loop, into `out`: n - 2, three places in the loop each.  area and
   best: of the run from i to j at i * n + j.  Returns their area (Barequet and Sharir 1995, "Filling gaps in the
   boundary of a polyhedron"). */
static double pbwm3__least_area(const pbwm3__work *w, const pbw_index *loop, size_t n, double *area, pbw_index *best,
                                pbwsf__triple *out)
{
    size_t length, i, j, k, count, done;
    for (length = 1; length < n; length++) {
        for (i = 0; i + length < n; i++) {
            double least = length > 1 ? HUGE_VAL : 0;
            j = i + length;
            for (k = i + 1; k < j; k++) {
                double normal[3], sum = area[i * n + k] + area[k * n + j];
                pbwsf__normal(w->vertices.at[loop[i]], w->vertices.at[loop[k]], w->vertices.at[loop[j]], normal);
                sum += sqrt(pbwsf__dot(normal, normal)) / 2;
                if (sum < least || k == i + 1) {
                    least = sum;
                    best[i * n + j] = (pbw_index)k;
                }
            }
            area[i * n + j] = least;
        }
    }
    out[0][0] = 0;
    out[0][2] = (pbw_index)(n - 1);
    for (done = 0, count = 1; done < count; done++) {            /* a run's triangle, then both of its parts */
        pbw_index *run = out[done];
        run[1] = best[(size_t)run[0] * n + run[2]];
        for (i = 0; i < 2; i++) {
            if (run[i + 1] - run[i] > 1) {
                out[count][0] = run[i];
                out[count++][2] = run[i + 1];
            }
        }
    }
    return area[n - 1];
}

/* Adds a triangle to a shell, unless it has a corner twice. */
static int pbwm3__close_with(pbwm3__work *w, pbw_index a, pbw_index b, pbw_index c, pbw_index shell)
{
    const pbw_index t[3] = { a, b, c }, none = PBW_NONE;
    if (a == b || b == c || c == a) {
        return 1;
    }
    return PBWM3__APPEND(w, w->triangles, t) && PBW_PUSH(&w->memory, w->origin, none)
        && PBW_PUSH(&w->memory, w->shell, shell);
}

enum { PBWM3__LOOP = 400 };                /* points of a loop whose least area is found; longer ones become fans */

/* Closes a loop of n points by a fan around its middle.  Returns 0 without memory. */
static int pbwm3__close_by_fan(pbwm3__work *w, const pbw_index *loop, size_t n, pbw_index number,
                               pbw_solid_hole *hole)
{
    pbwsf__vector *x = w->vertices.at;
    size_t i;
    for (i = 0; i < n; i++) {
        double normal[3];
        pbwsf__normal(hole->place, x[loop[i]], x[loop[(i + 1) % n]], normal);
        w->closing_area += sqrt(pbwsf__dot(normal, normal)) / 2;
    }
    if (!PBWM3__APPEND(w, w->vertices, hole->place)) {
        return 0;
    }
    for (i = 0; i < n; i++) {
        if (!pbwm3__close_with(w, loop[(i + 1) % n], loop[i], (pbw_index)(w->vertices.count - 1), number)) {
            return 0;
        }
    }
    return 1;
}

static int pbwm3__close_loop(pbwm3__work *w, const pbw_index *loop, size_t n, pbw_index number, pbw_solid_hole *hole)
{
    pbwsf__numbers area = { NULL, 0, 0 };
    pbwsf__indices best = { NULL, 0, 0 };
    pbwsf__triples out = { NULL, 0, 0 };
    size_t i;
    int good;
    if (n > PBWM3__LOOP) {
        return pbwm3__close_by_fan(w, loop, n, number, hole);
    }
    good = PBW_FIT(&w->memory, area, n * n) && PBW_FIT(&w->memory, best, n * n) && PBW_FIT(&w->memory, out, n);
    if (good) {
        w->closing_area += pbwm3__least_area(w, loop, n, area.at, best.at, out.at);
    }
    for (i = 0; i + 2 < n && good; i++) {
        good = pbwm3__close_with(w, loop[out.at[i][2]], loop[out.at[i][1]], loop[out.at[i][0]], number);
    }
    PBW_RELEASE(&w->memory, area);
    PBW_RELEASE(&w->memory, best);
    PBW_RELEASE(&w->memory, out);
    return good;
}

/* Lists the points of the loop that starts with an open edge, and marks its edges used (triangle = PBW_NONE).  head:
   the first edge from each point.  Returns 0 without memory; *closed: whether the loop returns to its first point. */
static int pbwm3__walk_loop(pbwm3__work *w, pbwm3__open_edge *e, size_t start, const pbw_index *head,
                            pbwsf__indices *loop, int *closed)
{
    pbw_index at = (pbw_index)start;
    loop->count = 0;
    while (at != PBW_NONE) {
        e[at].triangle = PBW_NONE;
        if (!PBW_PUSH(&w->memory, *loop, e[at].a)) {
            return 0;
        }
        *closed = e[at].b == e[start].a;
        for (at = *closed ? PBW_NONE : head[e[at].b]; at != PBW_NONE && e[at].triangle == PBW_NONE;
             at = e[at].next) {
        }
    }
    return 1;
}

static int pbwm3__name_hole(pbwm3__work *w, const pbw_index *loop, size_t n, int closed, pbw_index shell)
{
    pbwsf__vector *x = w->vertices.at;
    pbw_solid_hole hole;
    size_t i;
    int k;
    memset(&hole, 0, sizeof hole);
    hole.edges = n;
    for (i = 0; i < n; i++) {
        hole.length += pbwsf__distance(x[loop[i]], x[loop[(i + 1) % n]]);
        for (k = 0; k < 3; k++) {
            hole.place[k] += x[loop[i]][k] / (double)n;
        }
    }
    hole.closed = closed && n > 2;
    w->open |= !hole.closed;
    return (!hole.closed || pbwm3__close_loop(w, loop, n, shell, &hole))
        && PBW_PUSH(&w->memory, w->holes, hole);
}

static int pbwm3__compare_holes(const void *a, const void *b)
{
    const pbw_solid_hole *x = (const pbw_solid_hole *)a, *y = (const pbw_solid_hole *)b;
    int k;
    if (x->edges != y->edges) {
        return x->edges < y->edges ? 1 : -1;
    }
    if (x->length < y->length || x->length > y->length) {
        return x->length < y->length ? 1 : -1;
    }
    for (k = 0; k < 2 && !(x->place[k] < y->place[k] || x->place[k] > y->place[k]); k++) {
    }
    return (x->place[k] > y->place[k]) - (x->place[k] < y->place[k]);
}

static int pbwm3__find_holes(pbwm3__work *w, pbwm3__open_edges *open)
{
    pbwm3__open_edge *e = open->at;
    pbwsf__indices heads = { NULL, 0, 0 }, loop = { NULL, 0, 0 };
    size_t i, k;
    int good, closed = 0;
    good = PBW_FIT(&w->memory, heads, w->vertices.count + 1);
    if (good) {
        memset(heads.at, 0xff, heads.capacity * sizeof *heads.at);
    }
    for (i = open->count; good && i-- > 0;) {
        const pbw_index *c = w->triangles.at[e[i].triangle];
        const pbw_index a = e[i].a;
        for (k = 0; c[k] != a; k++) {
        }
        w->shells.at[w->shell.at[e[i].triangle]].open = 1;
        e[i].a = c[(k + 1) % 3] == e[i].b ? a : e[i].b;    /* as the triangle is turned now */
        e[i].b = e[i].a == a ? e[i].b : a;
        e[i].next = heads.at[e[i].a];
        heads.at[e[i].a] = (pbw_index)i;
    }
    for (i = 0; good && i < open->count; i++) {
        const pbw_index triangle = e[i].triangle;
        good = triangle == PBW_NONE
            || (pbwm3__walk_loop(w, e, i, heads.at, &loop, &closed)
                && pbwm3__name_hole(w, loop.at, loop.count, closed,
                                    w->shell.at[triangle]));
    }
    if (good && w->holes.count > 0) {
        qsort(w->holes.at, w->holes.count, sizeof(pbw_solid_hole), pbwm3__compare_holes);
        memcpy(w->report->hole, w->holes.at, sizeof(pbw_solid_hole)
               * (w->holes.count < PBW_SOLID_PLACES ? w->holes.count : (size_t)PBW_SOLID_PLACES));
    }
    w->report->holes = w->holes.count;
    PBW_RELEASE(&w->memory, heads);
    PBW_RELEASE(&w->memory, loop);
    return good;
}

/* ---- walls: shells that have triangles or edges in common ---- */

/* Leaves out triangles with the corners of earlier ones. */
static int pbwm3__drop_doubles(pbwm3__work *w)
{
    const size_t count = w->triangles.count;
    pbwim__sorting sorting;
    pbwsf__flags gone = { NULL, 0, 0 };
    pbwim__facet *facet;
    size_t i, kept = 0;
    int good;
    memset(&sorting, 0, sizeof sorting);
    good = pbwim__begin_sorting(&w->memory, &sorting, count, w->vertices.count)
        && PBW_FIT(&w->memory, gone, count + 1);
    facet = sorting.items.at;
    for (i = 0; good && i < count; i++) {
        memcpy(facet[i].v, w->triangles.at[i], sizeof facet[i].v);
        pbwim__sort3(facet[i].v);
        facet[i].t = (pbw_index)i;
        facet[i].i = 0;
        gone.at[i] = 0;
    }
    facet = good ? pbwim__sort(pbwm3__inner_options(w), &sorting, count, 3) : NULL;
    good = facet != NULL;
    for (i = 1; good && i < count; i++) {            /* of equal ones, the first comes first */
        gone.at[facet[i].t] = memcmp(facet[i].v, facet[i - 1].v, sizeof facet[i].v) == 0;
    }
    for (i = 0; good && i < count; i++) {
        if (!gone.at[i]) {
            memmove(w->triangles.at[kept], w->triangles.at[i], sizeof *w->triangles.at);
            w->origin.at[kept++] = w->origin.at[i];
        }
    }
    w->report->doubles = good ? count - kept : 0;
    w->triangles.count = w->origin.count = good ? kept : count;
    pbwim__end_sorting(&w->memory, &sorting);
    PBW_RELEASE(&w->memory, gone);
    return good;
}

/* A triangle at an edge from a to b, for the sort by angle around the edge.  c: its third corner; first: that of the
   first triangle there. */
typedef struct pbwm3__radial {
    const double *a, *b, *c, *first;
    int half;                              /* the angle from the first: 0 none, 1 below 180 degrees, 2 180, 3 above */
    size_t up, down;                       /* its sides to larger and smaller angles: 2 t in front, 2 t + 1 behind */
} pbwm3__radial;

static int pbwm3__half_of(const pbwm3__radial *r)
{
    const int sign = pbw_orient3(r->a, r->b, r->first, r->c);
    double n[2][3];
    if (sign != 0) {
        return sign > 0 ? 1 : 3;
    }
    pbwsf__normal(r->a, r->b, r->first, n[0]);
    pbwsf__normal(r->a, r->b, r->c, n[1]);
    return pbwsf__dot(n[0], n[1]) < 0 ? 2 : 0;
}

/* Compares two triangles at an edge by their angles around it, by exact signs. */
static int pbwm3__compare_radials(const void *p, const void *q)
{
    const pbwm3__radial *x = (const pbwm3__radial *)p, *y = (const pbwm3__radial *)q;
    int sign = x->half - y->half;
    if (sign == 0 && (x->half == 1 || x->half == 3)) {
        sign = -pbw_orient3(x->a, x->b, x->c, y->c);
    }
    if (sign == 0 && x->up % 2 != y->up % 2) {       /* one lies on the other: their fronts see each other */
        return x->up % 2 == 0 ? -1 : 1;
    }
    return sign != 0 ? sign : (x->up > y->up) - (x->up < y->up);
}

/* Joins sides that see each other across an edge, and the triangles at an edge to bodies.  parent: sides, then
   bodies. */
static int pbwm3__join_sides(pbwm3__work *w, size_t *parent)
{
    const size_t triangles = w->triangles.count, count = 3 * triangles;
    pbwsf__triple *corner = w->triangles.at;
    pbwsf__vector *x = w->vertices.at;
    pbwim__sorting sorting;
    PBW_ARRAY(pbwm3__radial) room = { NULL, 0, 0 };
    const pbwim__facet *edge = pbwm3__edges(w, corner[0], triangles, w->vertices.count, &sorting);
    size_t i, k, j;
    int good = edge != NULL;
    for (i = 0; good && i < count; i = k) {
        pbwm3__radial radial, *radials;
        room.count = 0;
        for (k = i; good && k < count && memcmp(edge[i].v, edge[k].v, 2 * sizeof(pbw_index)) == 0; k++) {
            radial.a = x[edge[i].v[0]];
            radial.b = x[edge[i].v[1]];
            radial.c = x[corner[edge[k].t][(edge[k].i + 2) % 3]];
            radial.first = k == i ? radial.c : room.at->c;
            radial.half = k == i ? 0 : pbwm3__half_of(&radial);
            radial.up = 2 * (size_t)edge[k].t + (edge[k].v[2] ? 0 : 1);
            radial.down = radial.up ^ 1;
            pbwm3__join(parent, 2 * triangles + edge[i].t, 2 * triangles + edge[k].t);
            good = PBW_PUSH(&w->memory, room, radial);
        }
        radials = room.at;
        if (good) {
            qsort(radials, room.count, sizeof radial, pbwm3__compare_radials);
        }
        for (j = 0; good && j < room.count; j++) {
            pbwm3__join(parent, radials[j].up, radials[(j + 1) % room.count].down);
        }
    }
    pbwim__end_sorting(&w->memory, &sorting);
    PBW_RELEASE(&w->memory, room);
    return good;
}

/* Adds up the volumes that the sides of triangles look into, at their roots. */
static void pbwm3__fill_volumes(const pbwm3__work *w, size_t *parent, double *volume)
{
    pbwsf__triple *c = w->triangles.at;
    pbwsf__vector *x = w->vertices.at;
    double middle[3], p[3][3], n[3];
    size_t i;
    int k;
    pbwsf__between(w->low, w->high, 0.5, middle);
    for (i = 0; i < 2 * w->triangles.count; i++) {
        volume[i] = 0;
    }
    for (i = 0; i < w->triangles.count; i++) {
        for (k = 0; k < 3; k++) {
            pbwsf__minus(x[c[i][k]], middle, p[k]);
        }
        pbwsf__normal(p[0], p[1], p[2], n);
        volume[pbwm3__root_of(parent, 2 * i)] -= pbwsf__dot(p[0], n) / 6;
        volume[pbwm3__root_of(parent, 2 * i + 1)] += pbwsf__dot(p[0], n) / 6;
    }
}

/* Finds the shells of a complex of walls: sets of sides that see each other across edges and enclose a volume.  They
   are numbered by their first triangles, the side behind before that in front. */
static int pbwm3__find_walls(pbwm3__work *w)
{
    const size_t triangles = w->triangles.count;
    pbwsf__counts parents = { NULL, 0, 0 };
    pbwsf__numbers volumes = { NULL, 0, 0 };
    pbwm3__shell shell;
    pbw_index *sides, *outer;
    size_t *parent, i;
    double *volume;
    int good;
    memset(&shell, 0, sizeof shell);
    good = pbwm3__start_trees(&w->memory, &parents, 3 * triangles)
        && PBW_FIT(&w->memory, volumes, 2 * triangles + 1)
        && PBW_FIT(&w->memory, w->sides, 2 * triangles + 1)
        && PBW_FIT(&w->memory, w->outer, triangles + 1);
    parent = parents.at;
    volume = volumes.at;
    sides = w->sides.at;
    outer = w->outer.at;
    good = good && pbwm3__join_sides(w, parent);
    if (good) {
        pbwm3__fill_volumes(w, parent, volume);
        memset(sides, 0xff, 2 * triangles * sizeof *sides);
    }
    w->shells.count = 0;
    for (i = 0; good && i < 2 * triangles; i++) {
        const size_t side = i ^ 1, root = pbwm3__root_of(parent, side);      /* behind, in front */
        if (volume[root] > 0 && sides[root] == PBW_NONE) {
            shell.volume = volume[root];
            shell.triangle = (pbw_index)(i / 2);
            shell.body = pbwm3__root_of(parent, 2 * triangles + i / 2) - 2 * triangles;
            sides[root] = (pbw_index)w->shells.count;
            good = PBW_PUSH(&w->memory, w->shells, shell);
        }
    }
    for (i = 0; good && i < 2 * triangles; i++) {
        sides[i] = sides[pbwm3__root_of(parent, i)];
        outer[i / 2] = (pbw_index)(pbwm3__root_of(parent, 2 * triangles + i / 2) - 2 * triangles);
    }
    w->report->shells = w->shells.count;
    PBW_RELEASE(&w->memory, parents);
    PBW_RELEASE(&w->memory, volumes);
    return good;
}

/* Finds the shells, turns them, and closes holes. */
static int pbwm3__find_shells(pbwm3__work *w)
{
    const size_t count = w->triangles.count;
    pbwm3__orientation trees;
    pbwsf__counts parents = { NULL, 0, 0 };
    pbwsf__flags flipped = { NULL, 0, 0 };
    pbwm3__open_edges open = { NULL, 0, 0 };
    double sum = 0;
    size_t i;
    int good = pbwm3__start_trees(&w->memory, &parents, count) && PBW_ZEROS(&w->memory, flipped, count);
    trees.parent = parents.at;
    trees.flipped = flipped.at;
    good = good && pbwm3__join_shells(w, &trees, &open) && pbwm3__number_shells(w, &trees);
    w->first_closing = count;
    w->walls = open.count == 0 && w->report->crowded_edges + w->report->doubles > 0;
    if (good && open.count > 0) {
        w->open = w->report->crowded_edges > 0;
        good = pbwm3__measure_shells(w) && pbwm3__find_holes(w, &open);
        for (i = 0; i < w->shells.count; i++) {
            sum += w->shells.at[i].area;
            w->shells.at[i].open &= w->open;
        }
        w->report->hole_share = sum > 0 ? w->closing_area / sum : 0;
    }
    if (good && w->walls) {
        good = pbwm3__find_walls(w);
    } else {
        good = good && pbwm3__measure_shells(w);
    }
    PBW_RELEASE(&w->memory, parents);
    PBW_RELEASE(&w->memory, flipped);
    PBW_RELEASE(&w->memory, open);
    return good;
}

/* ------------------------------------------------------------------------------------------------------
   >>inside       Which shells are around a point, and which triangles cross.
   In: oriented shells, and the tree of their triangles.  Out: the label of a place; points moved to the surface.
   ------------------------------------------------------------------------------------------------------ */

enum { PBWM3__ODD = 64 };                  /* shells that one ray keeps in mind */

typedef struct pbwm3__ray_shells {
    const pbwm3__work *w;
    size_t own;                            /* the body whose shells do not count */
    size_t step, rest;                     /* of the shells rest, rest + step, ... */
    pbw_index odd[PBWM3__ODD];             /* those that the ray has crossed an odd number of times */
    size_t count;
    int full;                              /* there were more */
    size_t around;                         /* out: how many shells are around the point, and the innermost */
    pbw_index innermost;
} pbwm3__ray_shells;

/* The shell in front of a triangle or behind it, PBW_NONE if that side is out of the body. */
static pbw_index pbwm3__side(const pbwm3__work *w, pbw_index triangle, int back)
{
    return w->walls ? w->sides.at[2 * (size_t)triangle + (size_t)back]
         : back ? w->shell.at[triangle] : PBW_NONE;
}

static void pbwm3__cross_shell(void *user, pbw_index triangle, int front)
{
    pbwm3__ray_shells *c = (pbwm3__ray_shells *)user;
    const pbwm3__shell *shells = c->w->shells.at;
    size_t i;
    int back;
    (void)front;
    for (back = 0; back < 2; back++) {
        const pbw_index shell = pbwm3__side(c->w, triangle, back);
        if (shell == PBW_NONE || shell % c->step != c->rest || shells[shell].body == c->own) {
            continue;
        }
        for (i = 0; i < c->count && c->odd[i] != shell; i++) {
        }
        if (i < c->count) {
            c->odd[i] = c->odd[--c->count];
        } else if (c->count < PBWM3__ODD) {
            c->odd[c->count++] = shell;
        } else {
            c->full = 1;
        }
    }
}

/* Returns how many shells are around p, without those of the body `own`, and the innermost.  If one ray crosses too
   many shells, several follow, each for some of them. */
static pbwm3__ray_shells pbwm3__shells_around(const pbwm3__work *w, const double p[3], size_t own)
{
    const pbwm3__shell *shells = w->shells.at;
    pbwm3__ray_shells c;
    size_t i;
    c.w = w;
    c.own = own;
    c.step = 1;
    do {
        c.around = 0;
        c.innermost = PBW_NONE;
        c.full = 0;
        for (c.rest = 0; c.rest < c.step && !c.full; c.rest++) {
            c.count = 0;
            pbwsf__ray(&w->surface, p, pbwm3__cross_shell, &c);
            c.around += c.count;
            for (i = 0; i < c.count; i++) {
                const double least = c.innermost == PBW_NONE ? HUGE_VAL : fabs(shells[c.innermost].volume);
                const double volume = fabs(shells[c.odd[i]].volume);
                if (volume < least || (!(volume > least) && c.odd[i] < c.innermost)) {
                    c.innermost = c.odd[i];
                }
            }
        }
        c.step *= 2;
    } while (c.full);
    return c;
}

/* With walls: returns the label inside a shell, its number + 1, or 0 for a cavity. */
static int pbwm3__shell_label(const pbwm3__work *w, pbw_index shell)
{
    return shell == PBW_NONE || (!w->nested && w->shells.at[shell].around % 2 == 1) ? 0
         : (int)shell + 1;
}

/* The label in front of a triangle or behind it, with walls. */
static int pbwm3__side_label(const pbwm3__work *w, pbw_index triangle, int back)
{
    const pbw_index shell = pbwm3__side(w, triangle, back);
    return pbwm3__shell_label(w, shell != PBW_NONE ? shell : w->outer.at[triangle]);
}

static void pbwm3__middle_of(const pbwm3__work *w, pbw_index triangle, double p[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        p[k] = (pbwsf__corner(&w->surface, triangle, 0)[k] + pbwsf__corner(&w->surface, triangle, 1)[k]
                + pbwsf__corner(&w->surface, triangle, 2)[k]) / 3;
    }
}

/* ---- triangles that cross ---- */

/* Counts pairs of triangles that meet elsewhere than in common corners and edges: those of the input, and others. */
static void pbwm3__count_crossings(pbwm3__work *w, const pbw_surface_faults *faults)
{
    pbw_solid_report *report = w->report;
    size_t i;
    for (i = 0; i < faults->crossing_count; i++) {
        const pbw_index *pair = faults->crossings + 2 * i;
        if (pair[0] >= w->first_closing || pair[1] >= w->first_closing) {
            report->closing_crossings++;
        } else if (report->crossings++ == 0) {
            memcpy(report->crossing_place, faults->segments + 6 * i, sizeof report->crossing_place);
        }
    }
}

static int pbwm3__has_crossings(const pbwm3__work *w)
{
    return !w->report->united && w->report->crossings + w->report->closing_crossings > 0;
}

static pbw_status pbwm3__find_crossings(pbwm3__work *w)
{
    const pbw_surface *s = &w->surface;
    pbw_surface_faults faults;
    const pbw_status status = pbw_surface_crossings(s->points, s->point_count, s->triangles, s->triangle_count,
                                                    pbwm3__inner_options(w), &faults);
    const size_t count = faults.crossing_count;
    int good = 1;
    pbwm3__count_crossings(w, &faults);
    w->joined = count > 0 && !w->nested && !w->open && !w->walls;
    if (w->joined) {
        good = PBW_FIT(&w->memory, w->crossing, count) && PBW_FIT(&w->memory, w->segments, 6 * count);
    }
    if (w->joined && good) {
        memcpy(w->crossing.at, faults.crossings, count * sizeof *w->crossing.at);
        memcpy(w->segments.at, faults.segments, 6 * count * sizeof *w->segments.at);
        w->crossing.count = count;
        w->segments.count = 6 * count;
    }
    pbw_surface_faults_free(&faults);
    return status != PBW_OK ? status : good ? PBW_OK : PBW_ERROR_MEMORY;
}

static void pbwm3__nest_shells(pbwm3__work *w)
{
    pbwm3__shell *shell = w->shells.at;
    pbw_index *outer = w->outer.at;
    double p[3];
    size_t i;
    for (i = 0; i < w->shells.count; i++) {
        pbwm3__middle_of(w, shell[i].triangle, p);
        shell[i].around = pbwm3__shells_around(w, p, shell[i].body).around;
        w->report->input_volume += (w->nested ? (shell[i].around == 0) : shell[i].around % 2 == 0 ? 1 : -1)
                                 * fabs(shell[i].volume);
    }
    for (i = 0; i < w->triangles.count && w->walls; i++) {       /* a body's number is its first triangle */
        const pbw_index body = outer[i];
        pbwm3__middle_of(w, (pbw_index)i, p);
        outer[i] = body == i ? pbwm3__shells_around(w, p, body).innermost : outer[body];
    }
}

/* Returns the label at p: 0 outside, else 1, or with nested shells the number of shells around it.  Inside an open
   surface is where its winding number is above 1/2, inside shells that cross where it is above 0. */
static int pbwm3__inside(const pbwm3__work *w, const double p[3])
{
    const double turns = w->walls ? 0 : w->open ? fabs(pbw_surface_winding(&w->surface, p))
                       : w->nested ? fabs((double)pbw_surface_turns(&w->surface, p)) : 0;
    return w->walls ? pbwm3__shell_label(w, pbwm3__shells_around(w, p, (size_t)-1).innermost)
         : w->joined ? pbw_surface_turns(&w->surface, p) > 0
         : !w->open && !w->nested ? pbw_surface_inside(&w->surface, p)
         : w->nested ? (int)fmin(turns + 0.5, 255) : turns > 0.5;
}

/* Moves p to the zero of the function, along its gradients: Newton's method, in steps of at most half a size. */
static void pbwm3__to_zero(const pbwm3__work *w, double p[3])
{
    const pbw_solid_input *in = w->input;
    const double h = 1e-4 * w->size;
    double a[3], b[3], n[3];
    int k, i;
    for (i = 0; i < 8; i++) {
        const double value = in->value(in->value_user, p);
        double square, step;
        for (k = 0; k < 3; k++) {
            memcpy(a, p, sizeof a);
            memcpy(b, p, sizeof b);
            a[k] -= h;
            b[k] += h;
            n[k] = (in->value(in->value_user, b) - in->value(in->value_user, a)) / (2 * h);
        }
        square = pbwsf__dot(n, n);
        if (!(square > 0) || !(fabs(value) > 1e-13 * sqrt(square) * w->size)) {
            break;
        }
        step = fmax(-0.5 * w->size, fmin(0.5 * w->size, value / sqrt(square))) / sqrt(square);
        for (k = 0; k < 3; k++) {
            p[k] -= step * n[k];
        }
    }
}

/* Returns the patch at p; moves p to the triangles, of a function only if its zero is farther than a size. */
static size_t pbwm3__to_patch(const pbwm3__work *w, double p[3])
{
    double place[3];
    const pbw_index t = pbw_surface_closest(&w->surface, p, HUGE_VAL, place);
    if (t == PBW_NONE) {
        return 0;
    }
    if (w->input->value == NULL || !(pbwsf__distance(p, place) < w->size)) {     /* Newton's method diverged */
        memcpy(p, place, sizeof place);
    }
    return w->patch.at[t];
}

/* Moves p to the surface, and returns the patch that it is on. */
static size_t pbwm3__to_surface(const pbwm3__work *w, double p[3])
{
    if (w->input->value != NULL) {
        pbwm3__to_zero(w, p);
    }
    return pbwm3__to_patch(w, p);
}

static void pbwm3__project(void *user, double p[3])
{
    (void)pbwm3__to_surface((const pbwm3__work *)user, p);
}

/* ------------------------------------------------------------------------------------------------------
   >>cuts         Where triangles are cut by others.
   In: pairs of triangles that meet, and what they have in common.  Out: vertices where triangles are cut, and which
   of them are on which edges and segments.
   New vertices are rounded, and those within 1e-7 sizes are one.
   ------------------------------------------------------------------------------------------------------ */
#define PBWM3__WELD 1e-7                   /* sizes */

typedef struct pbwm3__break { pbw_index a, b, vertex; } pbwm3__break;    /* a vertex on a line from a to b, a < b */

typedef struct pbwm3__span {               /* a segment in the plane */
    double x[2][2], low[2], high[2];       /* low, high: of its ranges along `axis` and across */
    size_t pair;
} pbwm3__span;

typedef struct pbwm3__ranked { double x; pbw_index id; } pbwm3__ranked;

typedef struct pbwm3__cutting {
    pbwsf__vectors points;                 /* vertices of the surface, then places */
    pbwsf__vectors places;                 /* ends of segments, two a pair, then crossings of segments */
    pbwsf__indices vertex;                 /* the point that each of them is */
    pbwsf__counts first, pairs;            /* of triangle t: pairs[first[t]] .. pairs[first[t + 1] - 1] */
    pbwsf__flags layer;                    /* per pair: 1, the triangles lie in one plane */
    pbwsf__pairs extra;                    /* a triangle, and a place where segments in it cross; ascending */
    PBW_ARRAY(pbwm3__break) breaks;
    pbwsf__pairs cuts;                     /* pieces of segments, sorted by edge */
    pbwsf__triples pieces;
    pbwsf__indices parent;                 /* of each piece, the triangle */
    pbwsf__counts piece_first;             /* of each triangle, the first piece */
    /* of one triangle */
    pbwsf__indices slot;                   /* per vertex, its place in `ids`, or PBW_NONE */
    pbwsf__indices ids;                    /* its vertices */
    pbwsf__numbers flat;                   /* two coordinates of each, so that the triangle turns left */
    pbwsf__pairs border, inner;            /* pieces of its edges, and of segments in it: places in `ids` */
    double axis[2];                        /* the direction across most segments in it, of length 1 */
    PBW_ARRAY(pbwm3__span) spans;
    PBW_ARRAY(pbwm3__ranked) sorted;        /* spans or vertices, by where they begin along the axis */
    pbwsf__pairs met;                      /* spans that cross */
    pbwsf__indices corner, next, incident; /* its triangulation, as in pbw_mesh */
} pbwm3__cutting;

/* ---- what cuts each triangle ---- */

/* Returns whether the triangles of a pair lie in one plane, up to rounding: their normals are alike, and the corners
   of one are in the plane of the other. */
static int pbwm3__is_layer(const pbwm3__work *w, const pbw_index *pair)
{
    double n[2][3], across[3], out[3];
    int i, nearby = 0;
    pbwsf__normal_of(&w->surface, pair[0], n[0]);
    pbwsf__normal_of(&w->surface, pair[1], n[1]);
    pbwsf__cross(n[0], n[1], across);
    if (!(pbwsf__dot(across, across) < 1e-6 * pbwsf__dot(n[0], n[0]) * pbwsf__dot(n[1], n[1]))) {
        return 0;
    }
    for (i = 0; i < 2 && nearby < 3; i++) {
        const double within = PBWM3__WELD * w->size * sqrt(pbwsf__dot(n[i], n[i]));
        for (nearby = 0; nearby < 3; nearby++) {
            pbwsf__minus(pbwsf__corner(&w->surface, pair[1 - i], nearby),
                         pbwsf__corner(&w->surface, pair[i], 0), out);
            if (!(fabs(pbwsf__dot(out, n[i])) <= within)) {
                break;
            }
        }
    }
    return nearby == 3;
}

/* Lists the pairs of each triangle, and the ends of their segments as places. */
static int pbwm3__list_pairs(pbwm3__work *w, pbwm3__cutting *c)
{
    const size_t triangles = w->surface.triangle_count, count = w->crossing.count;
    size_t *first, i;
    if (!PBW_ZEROS(&w->memory, c->first, triangles + 2) || !PBW_FIT(&w->memory, c->pairs, 2 * count + 1)
        || !PBW_FIT(&w->memory, c->layer, count + 1) || !PBW_FIT(&w->memory, c->places, 2 * count + 1)) {
        return 0;
    }
    first = c->first.at;
    for (i = 0; i < 2 * count; i++) {
        first[w->crossing.at[i / 2][i % 2] + 2]++;
    }
    for (i = 0; i < triangles; i++) {
        first[i + 2] += first[i + 1];
    }
    for (i = 0; i < 2 * count; i++) {
        c->pairs.at[first[w->crossing.at[i / 2][i % 2] + 1]++] = i / 2;
        memcpy(c->places.at[i], w->segments.at + 3 * i, sizeof *c->places.at);
    }
    c->places.count = 2 * count;
    for (i = 0; i < count; i++) {
        c->layer.at[i] = (unsigned char)pbwm3__is_layer(w, w->crossing.at[i]);
    }
    return 1;
}

/* The two coordinates of p in the plane of a triangle with normal n, which turns left there. */
static void pbwm3__flatten(const double n[3], const double p[3], double out[2])
{
    int k, most = 0;
    for (k = 1; k < 3; k++) {
        most = fabs(n[k]) > fabs(n[most]) ? k : most;
    }
    out[n[most] < 0] = p[(most + 1) % 3];
    out[n[most] >= 0] = p[(most + 2) % 3];
}

static int pbwm3__compare_spans(const void *a, const void *b)
{
    const pbwm3__span *x = (const pbwm3__span *)a, *y = (const pbwm3__span *)b;
    const double low = fmin(x->x[0][0], x->x[1][0]), other = fmin(y->x[0][0], y->x[1][0]);
    return low < other ? -1 : low > other ? 1 : (x->pair > y->pair) - (x->pair < y->pair);
}

static int pbwm3__compare_ranked(const void *a, const void *b)
{
    const pbwm3__ranked *x = (const pbwm3__ranked *)a, *y = (const pbwm3__ranked *)b;
    return x->x < y->x ? -1 : x->x > y->x ? 1 : (x->id > y->id) - (x->id < y->id);
}

static int pbwm3__compare_pairs(const void *a, const void *b)
{
    const pbw_index *x = (const pbw_index *)a, *y = (const pbw_index *)b;
    return x[0] != y[0] ? (x[0] > y[0]) - (x[0] < y[0]) : (x[1] > y[1]) - (x[1] < y[1]);
}

/* Widens a range to where x is along a direction, and by more than the rounding there, which is below 2 DBL_EPSILON
   of the products' sizes: half of one for each product, their sum and the end.  So where two segments cross, exactly,
   their ranges overlap. */
static void pbwm3__widen(const double axis[2], const double x[2], double *low, double *high)
{
    const double along = axis[0] * x[0] + axis[1] * x[1];
    const double slack = 4 * DBL_EPSILON * (fabs(axis[0] * x[0]) + fabs(axis[1] * x[1]));
    *low = fmin(*low, along - slack);
    *high = fmax(*high, along + slack);
}

/* Finds the direction along which the segments of a triangle with normal n are shortest, by the sum of squares. */
static void pbwm3__find_axis(pbwm3__cutting *c, pbw_index triangle, const double n[3])
{
    double xx = 0, xy = 0, yy = 0, half, root, x, y, length;
    size_t i;
    for (i = c->first.at[triangle]; i < c->first.at[triangle + 1]; i++) {
        double d[3], flat[2];
        pbwsf__minus(c->places.at[2 * c->pairs.at[i] + 1], c->places.at[2 * c->pairs.at[i]], d);
        pbwm3__flatten(n, d, flat);
        xx += flat[0] * flat[0];
        xy += flat[0] * flat[1];
        yy += flat[1] * flat[1];
    }
    half = (xx - yy) / 2;
    root = sqrt(half * half + xy * xy);              /* x, y: along most of them, an eigenvector */
    x = half >= 0 ? half + root : xy;
    y = half >= 0 ? xy : root - half;
    length = sqrt(x * x + y * y);
    c->axis[0] = length > 0 ? -y / length : 0;
    c->axis[1] = length > 0 ? x / length : 1;
}

static int pbwm3__spans_cross(const pbwm3__span *s, const pbwm3__span *t)
{
    const double (*x)[2] = s->x, (*y)[2] = t->x;
    return pbw_orient2(x[0], x[1], y[0]) * pbw_orient2(x[0], x[1], y[1]) < 0
        && pbw_orient2(y[0], y[1], x[0]) * pbw_orient2(y[0], y[1], x[1]) < 0;
}

/* Lists the spans that cross, in order. */
static int pbwm3__find_met(pbwm3__work *w, pbwm3__cutting *c)
{
    size_t i, k;
    int good = 1;
    c->sorted.count = c->met.count = 0;
    for (i = 0; good && i < c->spans.count; i++) {
        const pbwm3__ranked item = { c->spans.at[i].low[0], (pbw_index)i };
        good = PBW_PUSH(&w->memory, c->sorted, item);
    }
    if (good && c->spans.count > 1) {
        qsort(c->sorted.at, c->sorted.count, sizeof *c->sorted.at, pbwm3__compare_ranked);
    }
    for (i = 0; good && i < c->spans.count; i++) {
        const pbw_index id = c->sorted.at[i].id;
        const pbwm3__span *s = c->spans.at + id;
        for (k = i + 1; good && k < c->spans.count && c->sorted.at[k].x <= s->high[0]; k++) {
            const pbw_index other = c->sorted.at[k].id;
            const pbw_index pair[2] = { id < other ? id : other, id < other ? other : id };
            const pbwm3__span *t = c->spans.at + other;
            good = t->low[1] > s->high[1] || t->high[1] < s->low[1] || !pbwm3__spans_cross(s, t)
                || PBWM3__APPEND(w, c->met, pair);
        }
    }
    if (good && c->met.count > 1) {
        qsort(c->met.at, c->met.count, sizeof *c->met.at, pbwm3__compare_pairs);
    }
    return good;
}

/* Adds the place where two segments in a triangle cross. */
static int pbwm3__cross_spans(pbwm3__work *w, pbwm3__cutting *c, pbw_index triangle, const pbwm3__span *s,
                              const pbwm3__span *t)
{
    const double (*x)[2] = s->x, (*y)[2] = t->x;
    const pbw_index item[2] = { triangle, (pbw_index)c->places.count };
    double p[3], from, to;
    from = (y[1][0] - y[0][0]) * (x[0][1] - y[0][1]) - (y[1][1] - y[0][1]) * (x[0][0] - y[0][0]);
    to = (y[1][0] - y[0][0]) * (x[1][1] - y[0][1]) - (y[1][1] - y[0][1]) * (x[1][0] - y[0][0]);
    pbwsf__between(c->places.at[2 * s->pair], c->places.at[2 * s->pair + 1],
                   fabs(from) + fabs(to) > 0 ? fabs(from) / (fabs(from) + fabs(to)) : 0, p);
    return PBWM3__APPEND(w, c->places, p) && PBWM3__APPEND(w, c->extra, item);
}

/* Adds the places where segments cross in a triangle: it meets two others in one place. */
static int pbwm3__find_places(pbwm3__work *w, pbwm3__cutting *c, pbw_index triangle)
{
    double n[3], along[2];
    size_t i, k;
    int good = 1;
    pbwsf__normal_of(&w->surface, triangle, n);
    pbwm3__find_axis(c, triangle, n);
    along[0] = -c->axis[1];
    along[1] = c->axis[0];
    c->spans.count = 0;
    for (i = c->first.at[triangle]; good && i < c->first.at[triangle + 1]; i++) {
        pbwm3__span span;
        span.pair = c->pairs.at[i];
        span.low[0] = span.low[1] = HUGE_VAL;
        span.high[0] = span.high[1] = -HUGE_VAL;
        for (k = 0; k < 2; k++) {
            pbwm3__flatten(n, c->places.at[2 * span.pair + k], span.x[k]);
            pbwm3__widen(c->axis, span.x[k], span.low, span.high);
            pbwm3__widen(along, span.x[k], span.low + 1, span.high + 1);
        }
        good = c->layer.at[span.pair] || PBW_PUSH(&w->memory, c->spans, span);
    }
    if (good && c->spans.count > 1) {
        qsort(c->spans.at, c->spans.count, sizeof(pbwm3__span), pbwm3__compare_spans);
    }
    good = good && pbwm3__find_met(w, c);
    for (i = 0; good && i < c->met.count; i++) {
        good = pbwm3__cross_spans(w, c, triangle, c->spans.at + c->met.at[i][0], c->spans.at + c->met.at[i][1]);
    }
    return good;
}

/* Gives each vertex of the surface and each place a vertex: the nearest one within reach, else a new one; those of
   the surface come first.  They are sorted along a direction that no plane of a model is likely to be across. */
static pbw_status pbwm3__weld_places(pbwm3__work *w, pbwm3__cutting *c)
{
    static const double direction[3] = { 0.6123724, 0.5345225, 0.5824351 };
    const size_t old = w->vertices.count, count = old + c->places.count;
    const double within = PBWM3__WELD * w->size;
    pbwsf__numbers height = { NULL, 0, 0 };
    PBW_ARRAY(uint64_t) keys = { NULL, 0, 0 };
    pbwsf__indices order = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, k;
    int late;
    if (PBW_FIT(&w->memory, height, count) && PBW_FIT(&w->memory, keys, count) && PBW_FIT(&w->memory, order, count)
        && PBW_FIT(&w->memory, c->vertex, count) && PBW_FIT(&w->memory, c->points, count)) {
        for (i = 0; i < count; i++) {
            memcpy(c->points.at[i], i < old ? w->vertices.at[i] : c->places.at[i - old], sizeof *c->points.at);
            height.at[i] = pbwsf__dot(c->points.at[i], direction);
            keys.at[i] = pbw_sort_key(height.at[i]);
            c->vertex.at[i] = PBW_NONE;
        }
        c->points.count = count;
        status = pbw_sort(keys.at, count, pbwm3__inner_options(w), order.at);
    }
    for (late = 0; late < 2 && status == PBW_OK; late++) {
        for (i = 0; i < count; i++) {
            const size_t at = order.at[i];
            double best = within;
            int up;
            for (up = 0; (at >= old) == late && up < 2; up++) {
                for (k = i; best > within / 8 && (up ? ++k < count : k-- > 0);) {
                    const pbw_index other = c->vertex.at[order.at[k]];
                    double d;
                    if (!(fabs(height.at[order.at[k]] - height.at[at]) <= within)) {
                        break;
                    }
                    d = other == PBW_NONE ? HUGE_VAL : pbwsf__distance(c->points.at[other], c->points.at[at]);
                    if (d < best) {
                        best = d;
                        c->vertex.at[at] = other;
                    }
                }
            }
            if ((at >= old) == late && c->vertex.at[at] == PBW_NONE) {
                c->vertex.at[at] = (pbw_index)at;
            }
        }
    }
    PBW_RELEASE(&w->memory, height);
    PBW_RELEASE(&w->memory, keys);
    PBW_RELEASE(&w->memory, order);
    return status;
}

/* Returns whether a vertex is on an edge, up to rounding. */
static int pbwm3__is_on_edge(const pbwm3__work *w, const pbwm3__cutting *c, pbw_index vertex, pbw_index a,
                             pbw_index b)
{
    const double *p = c->points.at[vertex], *x = c->points.at[a], *y = c->points.at[b];
    double along[3], from[3], closest[3], square;
    pbwsf__minus(y, x, along);
    pbwsf__minus(p, x, from);
    square = pbwsf__dot(along, along);
    pbwsf__between(x, y, square > 0 ? fmin(1, fmax(0, pbwsf__dot(from, along) / square)) : 0, closest);
    return pbwsf__distance(p, closest) <= PBWM3__WELD * w->size;
}

static uint64_t pbwm3__edge_key(pbw_index a, pbw_index b)
{
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

/* Sorts breaks by line, then by how far along they are, and drops those that are there again. */
static pbw_status pbwm3__sort_breaks(pbwm3__work *w, pbwm3__cutting *c)
{
    const size_t count = c->breaks.count;
    PBW_ARRAY(uint64_t) keys = { NULL, 0, 0 };
    pbwsf__indices order = { NULL, 0, 0 };
    PBW_ARRAY(pbwm3__break) from = { NULL, 0, 0 };
    pbw_status status = PBW_FIT(&w->memory, keys, count + 1) && PBW_FIT(&w->memory, order, count + 1)
                     && PBW_FIT(&w->memory, from, count + 1) ? PBW_OK : PBW_ERROR_MEMORY;
    pbwm3__break *to = c->breaks.at;
    size_t i, kept = 0;
    int pass;
    for (pass = 0; pass < 2 && status == PBW_OK && count > 0; pass++) {
        for (i = 0; i < count; i++) {
            keys.at[i] = pass == 1 ? pbwm3__edge_key(to[i].a, to[i].b)
                       : pbw_sort_key(pbwsf__distance(c->points.at[to[i].a], c->points.at[to[i].vertex]));
        }
        memcpy(from.at, to, count * sizeof *to);
        status = pbw_sort(keys.at, count, pbwm3__inner_options(w), order.at);
        for (i = 0; i < count && status == PBW_OK; i++) {
            to[i] = from.at[order.at[i]];
        }
    }
    for (i = 0; i < count; i++) {
        if (i == 0 || to[i].a != to[kept - 1].a || to[i].b != to[kept - 1].b || to[i].vertex != to[kept - 1].vertex) {
            to[kept++] = to[i];
        }
    }
    c->breaks.count = kept;
    PBW_RELEASE(&w->memory, keys);
    PBW_RELEASE(&w->memory, order);
    PBW_RELEASE(&w->memory, from);
    return status;
}

/* ---- one triangle ---- */

/* The vertex of a triangle's corner. */
static pbw_index pbwm3__vertex_at(const pbwm3__work *w, const pbwm3__cutting *c, pbw_index triangle, int corner)
{
    return c->vertex.at[w->triangles.at[triangle][corner]];
}

/* The ends of a segment. */
static const pbw_index *pbwm3__ends_of(const pbwm3__work *w, const pbwm3__cutting *c, size_t pair)
{
    return c->vertex.at + w->vertices.count + 2 * pair;
}

/* The place of a vertex in `ids`, where it is added if it is not there; PBW_NONE without memory. */
static pbw_index pbwm3__local(pbwm3__work *w, pbwm3__cutting *c, pbw_index vertex)
{
    if (c->slot.at[vertex] == PBW_NONE && PBW_PUSH(&w->memory, c->ids, vertex)) {
        c->slot.at[vertex] = (pbw_index)(c->ids.count - 1);
    }
    return c->slot.at[vertex];
}

/* Adds the pieces of a line from a to b, between the breaks on it, to a list of places in `ids`. */
static int pbwm3__list_line(pbwm3__work *w, pbwm3__cutting *c, pbw_index a, pbw_index b, pbwsf__pairs *list)
{
    const pbwm3__break *at = c->breaks.at;
    const uint64_t key = pbwm3__edge_key(a, b);
    size_t low = 0, high = c->breaks.count;
    pbw_index piece[2];
    int good = 1, more = a != b;
    piece[0] = pbwm3__local(w, c, a < b ? a : b);
    while (low < high) {
        const size_t middle = (low + high) / 2;
        const int below = pbwm3__edge_key(at[middle].a, at[middle].b) < key;
        *(below ? &low : &high) = below ? middle + 1 : middle;
    }
    for (; good && more; low++) {
        more = low < c->breaks.count && pbwm3__edge_key(at[low].a, at[low].b) == key;
        piece[1] = pbwm3__local(w, c, more ? at[low].vertex : a < b ? b : a);
        good = piece[0] != PBW_NONE && piece[1] != PBW_NONE && PBWM3__APPEND(w, *list, piece);
        piece[0] = piece[1];
    }
    return good;
}

/* Adds the vertices of a triangle that are on a line from a to b as breaks. */
static int pbwm3__break_line(pbwm3__work *w, pbwm3__cutting *c, pbw_index a, pbw_index b)
{
    pbwm3__break one;
    size_t low = 0, high = c->sorted.count;
    double from = HUGE_VAL, to = -HUGE_VAL;
    int good = 1;
    pbwm3__widen(c->axis, c->flat.at + 2 * (size_t)c->slot.at[a], &from, &to);
    pbwm3__widen(c->axis, c->flat.at + 2 * (size_t)c->slot.at[b], &from, &to);
    from -= 2 * PBWM3__WELD * w->size;               /* more than a weld, as the axis has length 1 but for rounding */
    to += 2 * PBWM3__WELD * w->size;
    one.a = a < b ? a : b;
    one.b = a < b ? b : a;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        *(c->sorted.at[middle].x < from ? &low : &high) = c->sorted.at[middle].x < from ? middle + 1 : middle;
    }
    for (; good && low < c->sorted.count && c->sorted.at[low].x <= to; low++) {
        one.vertex = c->ids.at[c->sorted.at[low].id];
        good = one.vertex == a || one.vertex == b || !pbwm3__is_on_edge(w, c, one.vertex, a, b)
            || PBW_PUSH(&w->memory, c->breaks, one);
    }
    return good;
}

/* Lists the vertices of a triangle, and what its pieces must have as edges.  extra: the first of `extra` that may be
   in it, which is moved on. */
static int pbwm3__gather(pbwm3__work *w, pbwm3__cutting *c, pbw_index triangle, size_t *extra)
{
    double n[3];
    size_t i;
    int k, good = 1;
    c->ids.count = c->border.count = c->inner.count = 0;
    for (k = 0; good && k < 3; k++) {
        good = pbwm3__list_line(w, c, pbwm3__vertex_at(w, c, triangle, k), pbwm3__vertex_at(w, c, triangle,
                                (k + 1) % 3), &c->border);
    }
    for (i = c->first.at[triangle]; good && i < c->first.at[triangle + 1]; i++) {
        const pbw_index *ends = pbwm3__ends_of(w, c, c->pairs.at[i]);
        good = c->layer.at[c->pairs.at[i]]
            || (ends[0] == ends[1] ? pbwm3__local(w, c, ends[0]) != PBW_NONE
                : pbwm3__list_line(w, c, ends[0], ends[1], &c->inner));
    }
    for (; good && *extra < c->extra.count && c->extra.at[*extra][0] == triangle; ++*extra) {
        good = pbwm3__local(w, c, c->vertex.at[w->vertices.count + c->extra.at[*extra][1]]) != PBW_NONE;
    }
    good = good && PBW_FIT(&w->memory, c->flat, 2 * c->ids.count);
    pbwsf__normal_of(&w->surface, triangle, n);
    for (i = 0; good && i < c->ids.count; i++) {
        pbwm3__flatten(n, c->points.at[c->ids.at[i]], c->flat.at + 2 * i);
    }
    return good;
}

static void pbwm3__forget(pbwm3__cutting *c)
{
    size_t i;
    for (i = 0; i < c->ids.count; i++) {
        c->slot.at[c->ids.at[i]] = PBW_NONE;
    }
}

/* Adds breaks: the vertices of a triangle that are on its edges and segments. */
static int pbwm3__break_lines(pbwm3__work *w, pbwm3__cutting *c, pbw_index triangle, size_t *extra)
{
    double n[3];
    size_t i;
    int k, good = pbwm3__gather(w, c, triangle, extra);
    pbwsf__normal_of(&w->surface, triangle, n);
    pbwm3__find_axis(c, triangle, n);
    c->sorted.count = 0;
    for (i = 0; good && i < c->ids.count; i++) {
        pbwm3__ranked item;
        item.x = c->axis[0] * c->flat.at[2 * i] + c->axis[1] * c->flat.at[2 * i + 1];
        item.id = (pbw_index)i;
        good = PBW_PUSH(&w->memory, c->sorted, item);
    }
    if (good) {
        qsort(c->sorted.at, c->sorted.count, sizeof *c->sorted.at, pbwm3__compare_ranked);
    }
    for (k = 0; good && k < 3; k++) {
        good = pbwm3__break_line(w, c, pbwm3__vertex_at(w, c, triangle, k), pbwm3__vertex_at(w, c, triangle,
                                 (k + 1) % 3));
    }
    for (i = c->first.at[triangle]; good && i < c->first.at[triangle + 1]; i++) {
        const pbw_index *ends = pbwm3__ends_of(w, c, c->pairs.at[i]);
        good = c->layer.at[c->pairs.at[i]] || ends[0] == ends[1] || pbwm3__break_line(w, c, ends[0], ends[1]);
    }
    pbwm3__forget(c);
    return good;
}

enum { PBWM3__BREAK_PASSES = 6 };

/* Finds the vertices of all cuts, and the edges and segments that they are on: what breaks a segment in one of its
   triangles breaks it in the other, too, where it may be on more of them. */
static pbw_status pbwm3__find_cuts(pbwm3__work *w, pbwm3__cutting *c)
{
    const size_t triangles = w->surface.triangle_count;
    pbw_status status;
    size_t i, extra, before = 1;
    int pass, good = pbwm3__list_pairs(w, c);
    for (i = 0; good && i < triangles && !pbwm3__ends_at(w, i, 256); i++) {
        good = pbwm3__find_places(w, c, (pbw_index)i);
    }
    status = pbwm3__has_ended(w) ? PBW_CANCELLED : good ? pbwm3__weld_places(w, c) : PBW_ERROR_MEMORY;
    if (status == PBW_OK && !PBW_FIT(&w->memory, c->slot, c->points.count + 1)) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        memset(c->slot.at, 0xff, c->slot.capacity * sizeof *c->slot.at);
    }
    for (pass = 0; status == PBW_OK && pass < PBWM3__BREAK_PASSES && c->breaks.count != before; pass++) {
        before = c->breaks.count;
        for (i = extra = 0; good && i < triangles && !pbwm3__ends_at(w, i, 256); i++) {
            good = c->first.at[i] == c->first.at[i + 1] || pbwm3__break_lines(w, c, (pbw_index)i, &extra);
        }
        status = pbwm3__has_ended(w) ? PBW_CANCELLED : good ? pbwm3__sort_breaks(w, c) : PBW_ERROR_MEMORY;
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>pieces       Triangles cut to pieces.
   In: what is in each triangle, from >>cuts.  Out: pieces of the triangles, which meet in whole edges and corners
   alone; the edges where others meet them.
   The pieces of a triangle come from a constrained triangulation of what is in it, in the plane of two coordinates,
   by exact signs.
   ------------------------------------------------------------------------------------------------------ */
static int pbwm3__turn(const pbwm3__cutting *c, pbw_index u, pbw_index v, pbw_index p)
{
    return pbw_orient2(c->flat.at + 2 * (size_t)u, c->flat.at + 2 * (size_t)v, c->flat.at + 2 * (size_t)p);
}

/* Returns 3 t + i for the edge u v, across from corner i of the triangle to its left, PBW_NONE if there is none.
   crossed: 1, the edge that u v crosses first, instead, if u v is none. */
static pbw_index pbwm3__find_across_from(const pbwm3__cutting *c, pbw_index u, pbw_index v, int crossed)
{
    const pbw_index start = c->incident.at[u];
    pbw_index found = PBW_NONE, at;
    int back;
    for (back = 0; back < 2; back++) {               /* around u to the left, then to the right */
        for (at = start; at != PBW_NONE;) {
            const pbw_index *corner = c->corner.at + 3 * (size_t)at;
            const pbw_index k = corner[0] == u ? 0 : corner[1] == u ? 1 : 2;
            const pbw_index left = corner[(k + 2) % 3], right = corner[(k + 1) % 3];
            if (right == v) {
                return 3 * at + (k + 2) % 3;
            }
            if (crossed && left == v) {
                return PBW_NONE;
            }
            if (crossed && pbwm3__turn(c, u, v, right) < 0 && pbwm3__turn(c, u, v, left) > 0) {
                found = 3 * at + k;
            }
            at = c->next.at[3 * (size_t)at + (back ? (k + 2) % 3 : (k + 1) % 3)];
            if (at == start) {
                return found;
            }
        }
    }
    return found;
}

/* Turns edge i of triangle t, across from that corner, into the other diagonal of the two triangles there, if that is
   inside of both. */
static int pbwm3__flip_edge(pbwm3__cutting *c, pbw_index edge)
{
    const pbw_index t = edge / 3, i = edge % 3, s = c->next.at[edge];
    pbw_index *x = c->corner.at + 3 * (size_t)t, *y = c->corner.at + 3 * (size_t)s;
    pbw_index *m = c->next.at + 3 * (size_t)t, *n = c->next.at + 3 * (size_t)s;
    const pbw_index j = n[0] == t ? 0 : n[1] == t ? 1 : 2;
    const pbw_index p = x[i], u = x[(i + 1) % 3], v = x[(i + 2) % 3], q = y[j];
    const pbw_index to_vp = m[(i + 1) % 3], to_pu = m[(i + 2) % 3], to_uq = n[(j + 1) % 3], to_qv = n[(j + 2) % 3];
    pbw_index k;
    if (pbwm3__turn(c, p, u, q) <= 0 || pbwm3__turn(c, p, q, v) <= 0) {
        return 0;
    }
    x[0] = p, x[1] = u, x[2] = q;
    m[0] = to_uq, m[1] = s, m[2] = to_pu;
    y[0] = p, y[1] = q, y[2] = v;
    n[0] = to_qv, n[1] = to_vp, n[2] = t;
    for (k = 0; k < 3 && to_uq != PBW_NONE; k++) {
        pbw_index *link = c->next.at + 3 * (size_t)to_uq + k;
        *link = *link == s ? t : *link;
    }
    for (k = 0; k < 3 && to_vp != PBW_NONE; k++) {
        pbw_index *link = c->next.at + 3 * (size_t)to_vp + k;
        *link = *link == t ? s : *link;
    }
    c->incident.at[p] = c->incident.at[q] = c->incident.at[u] = t;
    c->incident.at[v] = s;
    return 1;
}

/* Makes a b an edge, by flips of those that it crosses (Sloan 1993, "A fast algorithm for generating constrained
   Delaunay triangulations").  queue: room.  Returns PBW_DEGENERATE if a vertex is on it or flips do not end. */
static pbw_status pbwm3__insert_edge(pbwm3__work *w, pbwm3__cutting *c, pbw_index a, pbw_index b,
                                     pbwsf__pairs *queue)
{
    pbw_index edge = pbwm3__find_across_from(c, a, b, 1);
    size_t done, most;
    if (edge == PBW_NONE || c->corner.at[edge] != a) {           /* it is one */
        return pbwm3__find_across_from(c, a, b, 0) != PBW_NONE || pbwm3__find_across_from(c, b, a, 0) != PBW_NONE
             ? PBW_OK : PBW_DEGENERATE;
    }
    queue->count = 0;
    for (;;) {                                       /* along a b, to the triangle of b */
        const pbw_index t = edge / 3, i = edge % 3, s = c->next.at[edge];
        const pbw_index *x = c->corner.at + 3 * (size_t)t, *n;
        const pbw_index pair[2] = { x[(i + 1) % 3], x[(i + 2) % 3] };
        pbw_index j, apex;
        int side;
        if (s == PBW_NONE || !PBWM3__APPEND(w, *queue, pair)) {
            return s == PBW_NONE ? PBW_DEGENERATE : PBW_ERROR_MEMORY;
        }
        n = c->next.at + 3 * (size_t)s;
        j = n[0] == t ? 0 : n[1] == t ? 1 : 2;
        apex = c->corner.at[3 * (size_t)s + j];
        if (apex == b) {
            break;
        }
        side = pbwm3__turn(c, a, b, apex);
        if (side == 0) {
            return PBW_DEGENERATE;
        }
        edge = 3 * s + (side > 0 ? (j + 1) % 3 : (j + 2) % 3);
    }
    most = 64 + 16 * queue->count * (queue->count < 64 ? queue->count : 64);
    for (done = 0; done < queue->count && done < most; done++) {
        const pbw_index u = queue->at[done][0], v = queue->at[done][1];
        pbw_index pair[2], s;
        edge = pbwm3__find_across_from(c, u, v, 0);
        s = edge != PBW_NONE ? c->next.at[edge] : PBW_NONE;
        if (s == PBW_NONE || pbwm3__ends_at(w, done, 1024)) {
            return s == PBW_NONE ? PBW_DEGENERATE : PBW_CANCELLED;
        }
        pair[0] = u;
        pair[1] = v;
        if (pbwm3__flip_edge(c, edge)) {             /* the new edge: from corner 0 to corner 2 of the first */
            pair[0] = c->corner.at[edge / 3 * 3];
            pair[1] = c->corner.at[edge / 3 * 3 + 2];
            if (pair[0] == a || pair[0] == b || pair[1] == a || pair[1] == b
                || pbwm3__turn(c, a, b, pair[0]) == pbwm3__turn(c, a, b, pair[1])) {
                continue;
            }
        }
        if (!PBWM3__APPEND(w, *queue, pair)) {
            return PBW_ERROR_MEMORY;
        }
    }
    return done == queue->count ? PBW_OK : PBW_DEGENERATE;
}

/* Triangulates the vertices of a triangle.  Returns PBW_DEGENERATE if they are collinear. */
static pbw_status pbwm3__triangulate_flat(pbwm3__work *w, pbwm3__cutting *c)
{
    pbw_options options = *pbwm3__inner_options(w);
    pbw_mesh mesh;
    pbw_status status;
    memset(&mesh, 0, sizeof mesh);
    options.threads = 1;
    options.flags = PBW_BORROW | PBW_ANY_ORDER;
    options.progress = NULL;
    status = pbw_triangulate(2, c->flat.at, NULL, c->ids.count, &options, &mesh);
    status = status == PBW_OK && mesh.duplicate_count > 0 ? PBW_DEGENERATE : status;
    if (status == PBW_OK && (!PBW_FIT(&w->memory, c->corner, 3 * mesh.simplex_count)
                             || !PBW_FIT(&w->memory, c->next, 3 * mesh.simplex_count)
                             || !PBW_FIT(&w->memory, c->incident, mesh.point_count))) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        c->corner.count = 3 * mesh.simplex_count;
        memcpy(c->corner.at, mesh.simplices, c->corner.count * sizeof *c->corner.at);
        memcpy(c->next.at, mesh.neighbors, c->corner.count * sizeof *c->next.at);
        memcpy(c->incident.at, mesh.incident, mesh.point_count * sizeof *c->incident.at);
    }
    pbw_free(&mesh);
    return status;
}

/* Adds the triangles between the pieces of the edges to the surface's pieces: those that the hull does not reach
   without crossing them.  flags, queue: room. */
static int pbwm3__take_pieces(pbwm3__work *w, pbwm3__cutting *c, pbw_index triangle, pbwsf__flags *flags,
                              pbwsf__indices *queue)
{
    const size_t count = c->corner.count;
    size_t i, done;
    int good = PBW_ZEROS(&w->memory, *flags, count + count / 3);   /* of edges: 1, of the border; then of triangles */
    unsigned char *gone = good ? flags->at + count : NULL;
    queue->count = 0;
    for (i = 0; good && i < 2 * c->border.count; i++) {
        const pbw_index *pair = c->border.at[i / 2];
        const pbw_index edge = pbwm3__find_across_from(c, pair[i % 2], pair[1 - i % 2], 0);
        if (edge != PBW_NONE) {
            flags->at[edge] = 1;
        }
    }
    for (i = 0; good && i < count; i++) {
        if (c->next.at[i] == PBW_NONE && !flags->at[i] && !gone[i / 3]) {
            gone[i / 3] = 1;
            good = PBW_PUSH(&w->memory, *queue, (pbw_index)(i / 3));
        }
    }
    for (done = 0; good && done < queue->count; done++) {
        for (i = 3 * (size_t)queue->at[done]; good && i < 3 * (size_t)queue->at[done] + 3; i++) {
            const pbw_index next = c->next.at[i];
            if (next != PBW_NONE && !flags->at[i] && !gone[next]) {
                gone[next] = 1;
                good = PBW_PUSH(&w->memory, *queue, next);
            }
        }
    }
    for (i = 0; good && i < count / 3; i++) {
        const pbw_index *x = c->corner.at + 3 * i;
        const pbw_index piece[3] = { c->ids.at[x[0]], c->ids.at[x[1]], c->ids.at[x[2]] };
        good = gone[i] || (PBWM3__APPEND(w, c->pieces, piece) && PBW_PUSH(&w->memory, c->parent, triangle));
    }
    return good;
}

static pbw_status pbwm3__cut_triangle(pbwm3__work *w, pbwm3__cutting *c, pbw_index triangle, pbwsf__flags *flags,
                                      pbwsf__pairs *queue, pbwsf__indices *flood)
{
    pbw_status status = PBW_OK;
    pbw_index whole[3];
    size_t i;
    for (i = 0; i < c->inner.count; i++) {
        const pbw_index cut[2] = { c->ids.at[c->inner.at[i][0]], c->ids.at[c->inner.at[i][1]] };
        if (!PBWM3__APPEND(w, c->cuts, cut)) {
            return PBW_ERROR_MEMORY;
        }
    }
    for (i = 0; i < 3; i++) {                        /* corners within reach of each other: it is gone */
        if (pbwm3__vertex_at(w, c, triangle, (int)i) == pbwm3__vertex_at(w, c, triangle, (int)(i + 1) % 3)) {
            return PBW_OK;
        }
    }
    if (c->ids.count == 3) {
        for (i = 0; i < 3; i++) {
            whole[i] = pbwm3__vertex_at(w, c, triangle, (int)i);
        }
        return PBWM3__APPEND(w, c->pieces, whole) && PBW_PUSH(&w->memory, c->parent, triangle) ? PBW_OK
             : PBW_ERROR_MEMORY;
    }
    status = pbwm3__triangulate_flat(w, c);
    for (i = 0; status == PBW_OK && i < c->border.count + c->inner.count; i++) {
        const pbw_index *pair = i < c->border.count ? c->border.at[i] : c->inner.at[i - c->border.count];
        status = pbwm3__ends_at(w, i, 64) ? PBW_CANCELLED : pbwm3__insert_edge(w, c, pair[0], pair[1], queue);
    }
    for (i = 0; status == PBW_OK && i < c->border.count + c->inner.count; i++) {    /* no edge took another's place */
        const pbw_index *pair = i < c->border.count ? c->border.at[i] : c->inner.at[i - c->border.count];
        status = pbwm3__find_across_from(c, pair[0], pair[1], 0) != PBW_NONE
              || pbwm3__find_across_from(c, pair[1], pair[0], 0) != PBW_NONE ? PBW_OK : PBW_DEGENERATE;
    }
    return status != PBW_OK ? status
         : pbwm3__take_pieces(w, c, triangle, flags, flood) ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Cuts all triangles into pieces.  Returns PBW_DEGENERATE if rounding leaves one that cannot be. */
static pbw_status pbwm3__cut_all(pbwm3__work *w, pbwm3__cutting *c)
{
    const size_t triangles = w->surface.triangle_count;
    pbwsf__flags flags = { NULL, 0, 0 };
    pbwsf__pairs queue = { NULL, 0, 0 };
    pbwsf__indices flood = { NULL, 0, 0 };
    pbw_status status = PBW_FIT(&w->memory, c->piece_first, triangles + 1) ? PBW_OK : PBW_ERROR_MEMORY;
    size_t t, extra = 0;
    for (t = 0; status == PBW_OK && t < triangles; t++) {
        c->piece_first.at[t] = c->pieces.count;
        status = pbwm3__ends_at(w, t, 256) ? PBW_CANCELLED
               : !pbwm3__gather(w, c, (pbw_index)t, &extra) ? PBW_ERROR_MEMORY
               : pbwm3__cut_triangle(w, c, (pbw_index)t, &flags, &queue, &flood);
        pbwm3__forget(c);
    }
    if (status == PBW_OK) {
        c->piece_first.at[triangles] = c->pieces.count;
    }
    PBW_RELEASE(&w->memory, flags);
    PBW_RELEASE(&w->memory, queue);
    PBW_RELEASE(&w->memory, flood);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>union        Shells that cross, made one surface.
   In: pieces of triangles, which meet in whole edges and corners.  Out: the boundary of the union in the place of the
   surface, turned outward.
   Pieces that no cut separates are a patch, which is on the boundary if its front is outside of all shells and its
   back is not.  Of patches that lie on each other, turned alike, the first one counts.  The surface stays as it is if
   the patches enclose nothing or something else than the shells, or if they overlap: by rounding, or as a triangle
   could not be cut.
   ------------------------------------------------------------------------------------------------------ */
/* Returns whether p is in piece x of a triangle with normal n, in its plane. */
static int pbwm3__is_in_piece(const pbwm3__cutting *c, const double n[3], const pbw_index *x, const double p[3])
{
    double flat[3][2], q[2];
    int k;
    pbwm3__flatten(n, p, q);
    for (k = 0; k < 3; k++) {
        pbwm3__flatten(n, c->points.at[x[k]], flat[k]);
    }
    for (k = 0; k < 3 && pbw_orient2(flat[k], flat[(k + 1) % 3], q) >= 0; k++) {
    }
    return k == 3;
}

/* Returns whether a piece of a lower patch, turned alike, lies at a place of a piece. */
static int pbwm3__has_lower_layer(const pbwm3__work *w, const pbwm3__cutting *c, size_t *patch, size_t piece,
                                  const double p[3])
{
    const pbw_index t = c->parent.at[piece];
    size_t i, k;
    for (i = c->first.at[t]; i < c->first.at[t + 1]; i++) {
        const pbw_index *pair = w->crossing.at[c->pairs.at[i]], u = pair[0] == t ? pair[1] : pair[0];
        double n[2][3];
        if (!c->layer.at[c->pairs.at[i]]) {
            continue;
        }
        pbwsf__normal_of(&w->surface, t, n[0]);
        pbwsf__normal_of(&w->surface, u, n[1]);
        for (k = c->piece_first.at[u]; pbwsf__dot(n[0], n[1]) > 0 && k < c->piece_first.at[u + 1]; k++) {
            if (pbwm3__root_of(patch, k) < pbwm3__root_of(patch, piece)
                && pbwm3__is_in_piece(c, n[1], c->pieces.at[k], p)) {
                return 1;
            }
        }
    }
    return 0;
}

/* Returns whether a piece is on the boundary of the union: its front is outside of all shells, its back is not. */
static int pbwm3__is_outer(const pbwm3__work *w, const pbwm3__cutting *c, size_t *patch, size_t piece)
{
    const double *x[3];
    double n[3], middle[3], out[3], longest = 0, area, step;
    int i, k, turns[2];
    for (i = 0; i < 3; i++) {
        x[i] = c->points.at[c->pieces.at[piece][i]];
    }
    pbwsf__normal(x[0], x[1], x[2], n);
    area = sqrt(pbwsf__dot(n, n));
    for (i = 0; i < 3; i++) {
        longest = fmax(longest, pbwsf__distance(x[i], x[(i + 1) % 3]));
    }
    step = fmin(1e-6 * w->size, longest > 0 ? 0.1 * area / longest : 0);
    for (i = 0; i < 2; i++) {
        for (k = 0; k < 3; k++) {
            middle[k] = (x[0][k] + x[1][k] + x[2][k]) / 3;
            out[k] = middle[k] + (area > 0 ? (i == 0 ? step : -step) * n[k] / area : 0);
        }
        turns[i] = pbw_surface_turns(&w->surface, out) > 0;
    }
    return !turns[0] && turns[1] && !pbwm3__has_lower_layer(w, c, patch, piece, middle);
}

/* Joins the pieces that no cut separates: patch: trees of them. */
static int pbwm3__join_pieces(pbwm3__work *w, pbwm3__cutting *c, size_t *patch)
{
    const size_t count = 3 * c->pieces.count;
    pbwim__sorting sorting;
    const pbwim__facet *edge = pbwm3__edges(w, c->pieces.at[0], c->pieces.count, c->points.count, &sorting);
    size_t i, k, at = 0;
    const int good = edge != NULL;
    for (i = 0; good && i < count; i = k) {
        const uint64_t key = pbwm3__edge_key(edge[i].v[0], edge[i].v[1]);
        for (k = i + 1; k < count && memcmp(edge[i].v, edge[k].v, 2 * sizeof(pbw_index)) == 0; k++) {
        }
        while (at < c->cuts.count && pbwm3__edge_key(c->cuts.at[at][0], c->cuts.at[at][1]) < key) {
            at++;
        }
        if (k - i == 2 && !(at < c->cuts.count && pbwm3__edge_key(c->cuts.at[at][0], c->cuts.at[at][1]) == key)) {
            pbwm3__join(patch, edge[i].t, edge[i + 1].t);
        }
    }
    pbwim__end_sorting(&w->memory, &sorting);
    return good;
}

/* Sorts the cuts by their edges. */
static pbw_status pbwm3__sort_cuts(pbwm3__work *w, pbwsf__pairs *cuts)
{
    PBW_ARRAY(uint64_t) keys = { NULL, 0, 0 };
    pbwsf__indices order = { NULL, 0, 0 };
    pbw_status status = PBW_FIT(&w->memory, keys, cuts->count + 1) && PBW_FIT(&w->memory, order, cuts->count + 1)
                     ? PBW_OK : PBW_ERROR_MEMORY;
    size_t i;
    for (i = 0; status == PBW_OK && i < cuts->count; i++) {
        keys.at[i] = pbwm3__edge_key(cuts->at[i][0], cuts->at[i][1]);
    }
    status = status != PBW_OK || cuts->count == 0 ? status
           : pbw_sort(keys.at, cuts->count, pbwm3__inner_options(w), order.at);
    for (i = 0; status == PBW_OK && i < cuts->count; i++) {
        cuts->at[i][0] = (pbw_index)(keys.at[order.at[i]] >> 32);
        cuts->at[i][1] = (pbw_index)(keys.at[order.at[i]] & 0xffffffffu);
    }
    PBW_RELEASE(&w->memory, keys);
    PBW_RELEASE(&w->memory, order);
    return status;
}

/* Returns whether the pieces that are kept enclose something: each edge runs as often one way as the other. */
static int pbwm3__is_closed(pbwm3__work *w, const pbwsf__triples *pieces, size_t points, int *closed)
{
    pbwim__sorting sorting;
    const size_t count = 3 * pieces->count;
    const pbwim__facet *edge = pbwm3__edges(w, pieces->count > 0 ? pieces->at[0] : NULL, pieces->count, points,
                                            &sorting);
    size_t i, k;
    long sum;
    *closed = count > 0;
    for (i = 0; edge != NULL && i < count; i = k) {
        for (k = i, sum = 0; k < count && memcmp(edge[i].v, edge[k].v, 2 * sizeof(pbw_index)) == 0; k++) {
            sum += edge[k].v[2] ? 1 : -1;
        }
        *closed &= sum == 0;
    }
    pbwim__end_sorting(&w->memory, &sorting);
    return edge != NULL;
}

/* Keeps the pieces of patches that are on the boundary: those where the largest piece is. */
static pbw_status pbwm3__choose_pieces(pbwm3__work *w, pbwm3__cutting *c, int *closed)
{
    pbwsf__counts trees = { NULL, 0, 0 }, best = { NULL, 0, 0 };
    pbwsf__numbers areas = { NULL, 0, 0 };
    pbwsf__flags keeps = { NULL, 0, 0 };
    const size_t count = c->pieces.count;
    pbw_status status = pbwm3__sort_cuts(w, &c->cuts);
    size_t i, kept = 0;
    int good = status == PBW_OK && pbwm3__start_trees(&w->memory, &trees, count)
            && pbwm3__join_pieces(w, c, trees.at) && PBW_ZEROS(&w->memory, best, count + 1)
            && PBW_ZEROS(&w->memory, areas, count + 1) && PBW_ZEROS(&w->memory, keeps, count + 1);
    for (i = 0; good && i < count; i++) {
        const size_t root = pbwm3__root_of(trees.at, i);
        const pbw_index *x = c->pieces.at[i];
        double n[3];
        pbwsf__normal(c->points.at[x[0]], c->points.at[x[1]], c->points.at[x[2]], n);
        if (!(pbwsf__dot(n, n) <= areas.at[root])) {
            areas.at[root] = pbwsf__dot(n, n);
            best.at[root] = i;
        }
    }
    for (i = 0; good && i < count && !pbwm3__ends_at(w, i, 64); i++) {           /* a root is the least of its tree */
        const size_t root = pbwm3__root_of(trees.at, i);
        keeps.at[i] = root < i ? keeps.at[root] : (unsigned char)pbwm3__is_outer(w, c, trees.at, best.at[i]);
    }
    for (i = 0; good && i < count; i++) {
        if (keeps.at[i]) {
            memmove(c->pieces.at[kept], c->pieces.at[i], sizeof *c->pieces.at);
            c->parent.at[kept++] = c->parent.at[i];
        }
    }
    c->pieces.count = c->parent.count = good ? kept : count;
    good = good && pbwm3__is_closed(w, &c->pieces, c->points.count, closed);
    PBW_RELEASE(&w->memory, trees);
    PBW_RELEASE(&w->memory, best);
    PBW_RELEASE(&w->memory, areas);
    PBW_RELEASE(&w->memory, keeps);
    return pbwm3__has_ended(w) ? PBW_CANCELLED : good || status != PBW_OK ? status : PBW_ERROR_MEMORY;
}

/* Drops points that no piece has, and cuts with such an end. */
static pbw_status pbwm3__drop_unused(pbwm3__work *w, pbwm3__cutting *c)
{
    pbwsf__indices number = { NULL, 0, 0 };
    size_t i, used = 0;
    if (!PBW_FIT(&w->memory, number, c->points.count)) {
        return PBW_ERROR_MEMORY;
    }
    memset(number.at, 0xff, number.capacity * sizeof *number.at);    /* PBW_NONE */
    for (i = 0; i < 3 * c->pieces.count; i++) {
        number.at[c->pieces.at[i / 3][i % 3]] = 0;
    }
    for (i = 0; i < c->points.count; i++) {
        if (number.at[i] != PBW_NONE) {
            memmove(c->points.at[used], c->points.at[i], sizeof *c->points.at);
            number.at[i] = (pbw_index)used++;
        }
    }
    c->points.count = used;
    for (i = 0; i < 3 * c->pieces.count; i++) {
        pbw_index *corner = &c->pieces.at[i / 3][i % 3];
        *corner = number.at[*corner];
    }
    for (i = used = 0; i < c->cuts.count; i++) {     /* in their order */
        const pbw_index a = number.at[c->cuts.at[i][0]], b = number.at[c->cuts.at[i][1]];
        if (a != PBW_NONE && b != PBW_NONE) {
            c->cuts.at[used][0] = a;
            c->cuts.at[used++][1] = b;
        }
    }
    c->cuts.count = used;
    PBW_RELEASE(&w->memory, number);
    return PBW_OK;
}

/* Puts the pieces and their vertices in the place of the surface. */
static pbw_status pbwm3__take_union(pbwm3__work *w, pbwm3__cutting *c)
{
    const pbw_solid_report before = *w->report;
    pbwsf__vectors planes = { NULL, 0, 0 };
    pbwsf__indices origin = { NULL, 0, 0 };
    double volume = 0;
    size_t i, closing = 0;
    pbw_status status;
    if (!PBW_FIT(&w->memory, planes, c->pieces.count) || !PBW_FIT(&w->memory, origin, c->pieces.count)
        || pbwm3__drop_unused(w, c) != PBW_OK) {
        PBW_RELEASE(&w->memory, planes);
        PBW_RELEASE(&w->memory, origin);
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < c->pieces.count; i++) {
        const pbw_index parent = c->parent.at[i], *x = c->pieces.at[i];
        double out[3], n[3];
        closing += parent >= w->first_closing;
        origin.at[i] = w->origin.at[parent];
        pbwsf__normal_of(&w->surface, parent, planes.at[i]);
        pbwsf__normal(c->points.at[x[0]], c->points.at[x[1]], c->points.at[x[2]], n);
        pbwsf__minus(c->points.at[x[0]], w->low, out);
        volume += pbwsf__dot(out, n) / 6;            /* pieces are turned outward */
    }
    origin.count = planes.count = c->pieces.count;
    PBW_RELEASE(&w->memory, w->vertices);
    PBW_RELEASE(&w->memory, w->triangles);
    PBW_RELEASE(&w->memory, w->origin);
    pbwm3__drop_surface(w, &w->surface);
    w->vertices = c->points;
    w->triangles = c->pieces;
    w->origin = origin;
    w->planes = planes;
    w->cuts = c->cuts;
    memset(&c->points, 0, sizeof c->points);
    memset(&c->pieces, 0, sizeof c->pieces);
    memset(&c->cuts, 0, sizeof c->cuts);
    w->shells.count = 0;
    w->report->crowded_edges = w->report->doubles = 0;
    w->report->united = 1;
    w->joined = 0;
    if (!pbwm3__find_shells(w)) {
        return PBW_ERROR_MEMORY;
    }
    w->first_closing = w->triangles.count - closing;
    w->report->crowded_edges = before.crowded_edges;
    w->report->doubles = before.doubles;
    w->report->shells = before.shells;
    status = pbwm3__make_surface(w, w->vertices.at[0], w->vertices.count, w->triangles.at[0], w->triangles.count,
                                 &w->surface);
    if (status == PBW_OK) {
        pbwm3__nest_shells(w);
        w->report->input_volume = volume;
    }
    return status;
}

static void pbwm3__free_cutting(pbwm3__work *w, pbwm3__cutting *c)
{
    PBW_RELEASE(&w->memory, c->points);
    PBW_RELEASE(&w->memory, c->places);
    PBW_RELEASE(&w->memory, c->vertex);
    PBW_RELEASE(&w->memory, c->first);
    PBW_RELEASE(&w->memory, c->pairs);
    PBW_RELEASE(&w->memory, c->layer);
    PBW_RELEASE(&w->memory, c->extra);
    PBW_RELEASE(&w->memory, c->breaks);
    PBW_RELEASE(&w->memory, c->cuts);
    PBW_RELEASE(&w->memory, c->pieces);
    PBW_RELEASE(&w->memory, c->parent);
    PBW_RELEASE(&w->memory, c->piece_first);
    PBW_RELEASE(&w->memory, c->slot);
    PBW_RELEASE(&w->memory, c->ids);
    PBW_RELEASE(&w->memory, c->flat);
    PBW_RELEASE(&w->memory, c->border);
    PBW_RELEASE(&w->memory, c->inner);
    PBW_RELEASE(&w->memory, c->spans);
    PBW_RELEASE(&w->memory, c->sorted);
    PBW_RELEASE(&w->memory, c->met);
    PBW_RELEASE(&w->memory, c->corner);
    PBW_RELEASE(&w->memory, c->next);
    PBW_RELEASE(&w->memory, c->incident);
}

/* Cuts an interval to the projection of piece t on an axis. */
static void pbwm3__cut_interval(const pbwm3__cutting *c, size_t t, const double axis[3], double interval[2])
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    int k;
    for (k = 0; k < 3; k++) {
        const double at = pbwsf__dot(axis, c->points.at[c->pieces.at[t][k]]);
        low = fmin(low, at);
        high = fmax(high, at);
    }
    interval[0] = fmax(interval[0], low);
    interval[1] = fmin(interval[1], high);
}

/* Returns the least width that two pieces have in common, in the directions across their edges in their planes. */
static double pbwm3__common_width(const pbwm3__work *w, const pbwm3__cutting *c, const pbw_index *pair)
{
    double width = HUGE_VAL, n[3], along[3], axis[3], interval[2];
    int i, k;
    for (i = 0; i < 6; i++) {
        const pbw_index *x = c->pieces.at[pair[i / 3]];
        pbwsf__normal_of(&w->surface, c->parent.at[pair[i / 3]], n);
        pbwsf__minus(c->points.at[x[(i + 1) % 3]], c->points.at[x[i % 3]], along);
        pbwsf__cross(n, along, axis);
        interval[0] = -HUGE_VAL;
        interval[1] = HUGE_VAL;
        for (k = 0; k < 2; k++) {
            pbwm3__cut_interval(c, pair[k], axis, interval);
        }
        if (pbwsf__dot(axis, axis) > 0) {
            width = fmin(width, (interval[1] - interval[0]) / sqrt(pbwsf__dot(axis, axis)));
        }
    }
    return width;
}

/* *closed: 0 if pieces overlap in one plane by more than welds may move their edges, two of each piece.  Those of
   faces in one plane but for rounding do, as few of their triangles meet, exactly, and are cut.  Other pieces cross
   by rounding alone. */
static pbw_status pbwm3__find_overlaps(pbwm3__work *w, const pbwm3__cutting *c, int *closed)
{
    pbw_surface_faults faults;
    const pbw_status status = pbw_surface_crossings(c->points.at[0], c->points.count, c->pieces.at[0],
                                                    c->pieces.count, pbwm3__inner_options(w), &faults);
    size_t i;
    for (i = 0; status == PBW_OK && i < faults.crossing_count && *closed; i++) {
        const pbw_index *pair = faults.crossings + 2 * i;
        double n[2][3], across[3];
        pbwsf__normal_of(&w->surface, c->parent.at[pair[0]], n[0]);
        pbwsf__normal_of(&w->surface, c->parent.at[pair[1]], n[1]);
        pbwsf__cross(n[0], n[1], across);
        *closed = !(pbwsf__dot(across, across) < 1e-6 * pbwsf__dot(n[0], n[0]) * pbwsf__dot(n[1], n[1]))
               || pbwm3__common_width(w, c, pair) <= 4 * PBWM3__WELD * w->size;
    }
    pbw_surface_faults_free(&faults);
    return status;
}

enum { PBWM3__ASKED = 64 };                /* triangles of a shell, about */

/* Returns whether the pieces enclose what the shells do, at places before and behind a triangle.  The places are
   farther than welds, and seldom in the plane of another triangle. */
static int pbwm3__encloses_alike(const pbwm3__work *w, const pbw_surface *united, pbw_index triangle)
{
    static const double share[3] = { 0.4142136, 0.3247180, 0.2610684 };
    double n[3], p[3], length;
    int i, k, side, alike = 1;
    pbwsf__normal_of(&w->surface, triangle, n);
    length = sqrt(pbwsf__dot(n, n));
    for (side = -1; side < 2 && length > 0; side += 2) {
        for (k = 0; k < 3; k++) {
            p[k] = side * 10 * PBWM3__WELD * w->size * n[k] / length;
            for (i = 0; i < 3; i++) {
                p[k] += share[i] * pbwsf__corner(&w->surface, triangle, i)[k];
            }
        }
        alike = alike && pbw_surface_inside(united, p) == (pbw_surface_turns(&w->surface, p) > 0);
    }
    return alike;
}

/* *closed: 0 if the pieces do not enclose what the shells do, at some triangles of each.  A patch is lost where a cut
   is missing, as its largest piece is inside of a shell. */
static pbw_status pbwm3__compare_union(pbwm3__work *w, const pbwm3__cutting *c, int *closed)
{
    pbwsf__counts counts = { NULL, 0, 0 };
    pbw_surface united;
    pbw_status status;
    size_t t;
    memset(&united, 0, sizeof united);
    status = !PBW_ZEROS(&w->memory, counts, w->shells.count + 1) ? PBW_ERROR_MEMORY
           : pbwm3__make_surface(w, c->points.at[0], c->points.count, c->pieces.at[0], c->pieces.count, &united);
    for (t = 0; status == PBW_OK && t < w->triangles.count; t++) {
        counts.at[w->shell.at[t]]++;
    }
    for (t = 0; status == PBW_OK && *closed && t < w->triangles.count && !pbwm3__ends_at(w, t, 256); t++) {
        if (t % (1 + counts.at[w->shell.at[t]] / PBWM3__ASKED) == 0) {
            *closed = pbwm3__encloses_alike(w, &united, (pbw_index)t);
        }
    }
    pbwm3__drop_surface(w, &united);
    PBW_RELEASE(&w->memory, counts);
    return status == PBW_OK && pbwm3__has_ended(w) ? PBW_CANCELLED : status;
}

/* Makes one surface of shells that cross.  If rounding is in the way, they stay as they are. */
static pbw_status pbwm3__unite(pbwm3__work *w)
{
    pbwm3__cutting c;
    pbw_status status;
    size_t i;
    int closed = 0;
    memset(&c, 0, sizeof c);
    status = pbwm3__find_cuts(w, &c);
    status = status != PBW_OK ? status : pbwm3__cut_all(w, &c);
    status = status != PBW_OK ? status : pbwm3__choose_pieces(w, &c, &closed);
    status = status != PBW_OK || !closed ? status : pbwm3__find_overlaps(w, &c, &closed);
    status = status != PBW_OK || !closed ? status : pbwm3__compare_union(w, &c, &closed);
    status = status == PBW_DEGENERATE || (status == PBW_OK && !closed) ? PBW_OK
           : status != PBW_OK ? status : pbwm3__take_union(w, &c);
    for (i = 0; !w->report->united && i < w->shells.count; i++) {    /* one that crosses others is in none of them */
        w->report->input_volume = (i > 0 ? w->report->input_volume : 0) + fabs(w->shells.at[i].volume);
    }
    pbwm3__free_cutting(w, &c);
    PBW_RELEASE(&w->memory, w->crossing);
    PBW_RELEASE(&w->memory, w->segments);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>features     Sharp edges at the scale of the size.
   In: edges with an angle above the feature angle, in the order of all edges.  Out: which of them are kept.
   ------------------------------------------------------------------------------------------------------ */
/* Triangles that are visited on one side of an edge, at most: for the mean normal, and for the test of flatness. */
enum { PBWM3__FLOOD = 256, PBWM3__FLAT = 1024 };

typedef struct pbwm3__graph {              /* of sharp edges */
    pbwsf__pair *ends;
    size_t count;
    pbwsf__counts first, at;               /* edges at vertex v: at[first[v]] .. at[first[v + 1] - 1] */
    pbwsf__flags used;
} pbwm3__graph;

static int pbwm3__make_graph(pbwm3__work *w, pbwm3__graph *g)
{
    const size_t points = w->surface.point_count;
    size_t *first, i;
    if (!PBW_FIT(&w->memory, g->first, points + 2)
        || !PBW_FIT(&w->memory, g->at, 2 * g->count + 1)
        || !PBW_FIT(&w->memory, g->used, g->count + 1)) {
        return 0;
    }
    first = g->first.at;
    memset(first, 0, (points + 2) * sizeof *first);
    memset(g->used.at, 0, g->count + 1);
    for (i = 0; i < 2 * g->count; i++) {
        first[g->ends[i / 2][i % 2] + 2]++;
    }
    for (i = 0; i < points; i++) {
        first[i + 2] += first[i + 1];
    }
    for (i = 0; i < 2 * g->count; i++) {
        g->at.at[first[g->ends[i / 2][i % 2] + 1]++] = i / 2;
    }
    return 1;
}

/* The normal of a triangle; where shells are united, of that which it is a piece of, as a sliver has none. */
static void pbwm3__plane_of(const pbwm3__work *w, pbw_index t, double n[3])
{
    if (w->planes.count > 0) {
        memcpy(n, w->planes.at[t], 3 * sizeof *n);
    } else {
        pbwsf__normal_of(&w->surface, t, n);
    }
}

static pbw_index pbwm3__other_end(const pbwm3__graph *g, size_t edge, pbw_index v)
{
    return g->ends[edge][0] == v ? g->ends[edge][1] : g->ends[edge][0];
}

typedef struct pbwm3__features {
    const pbwim__facet *edge;              /* all edges, sorted */
    pbwsf__counts candidates;              /* where `edge` has those above the feature angle */
    pbwsf__flags keeps;                    /* 1: it is kept */
    pbwsf__counts across;                  /* per corner 3 t + i, the edge from it: 2 u, or 2 u + 1 if the triangle u
                                              across is turned the other way; (size_t)-1: none, or several */
    pbwsf__counts seen;                    /* per triangle: the last flood that had it */
    size_t floods;
    pbwm3__graph graph;                    /* of kept edges: the `fixed` first ones are always kept */
    size_t fixed;
    pbwsf__pairs ends;                     /* its edges */
    pbwsf__counts degree, branch;          /* how many are left at each vertex; those of a branch */
} pbwm3__features;

static int pbwm3__find_across(pbwm3__work *w, pbwm3__features *f)
{
    const size_t count = 3 * w->surface.triangle_count;
    size_t *across, i, k;
    if (!PBW_FIT(&w->memory, f->across, count + 1)
        || !PBW_FIT(&w->memory, f->seen, count / 3 + 1)) {
        return 0;
    }
    across = f->across.at;
    memset(across, 0xff, (count + 1) * sizeof *across);
    memset(f->seen.at, 0, f->seen.capacity * sizeof *f->seen.at);
    for (i = 0; i < count; i = k) {
        const pbwim__facet *e = f->edge + i;
        for (k = i + 1; k < count && memcmp(e->v, f->edge[k].v, 2 * sizeof(pbw_index)) == 0; k++) {
        }
        if (k - i == 2) {
            across[3 * (size_t)e[0].t + (size_t)e[0].i] = 2 * (size_t)e[1].t + (e[0].v[2] == e[1].v[2]);
            across[3 * (size_t)e[1].t + (size_t)e[1].i] = 2 * (size_t)e[0].t + (e[0].v[2] == e[1].v[2]);
        }
    }
    return 1;
}

/* Adds up the normals of the triangles that are connected with t, are near the middle, and lie on one side of the
   plane through it.  plane: the middle, and a vector to that side.  Each normal is at most as long as the square of
   the size.  flat 0: near is within a size; returns 0.  flat 1: near is within three sizes; returns whether the
   triangles are flat, to half a degree, and have the area of half a disk of that radius. */
static int pbwm3__mean_normal(const pbwm3__work *w, pbwm3__features *f, size_t t, const double plane[2][3], int flat,
                              double sum[3])
{
    const double *middle = plane[0], *side = plane[1], within = flat ? 3 * w->size : w->size;
    const size_t *across = f->across.at, most = flat ? PBWM3__FLAT : PBWM3__FLOOD;
    size_t queue[PBWM3__FLAT], count = 1, done, *seen = f->seen.at;
    double area = 0;
    int k, j;
    queue[0] = 2 * t;
    seen[t] = ++f->floods;
    sum[0] = sum[1] = sum[2] = 0;
    for (done = 0; done < count; done++) {
        const size_t at = queue[done] / 2;
        const double *c[3];
        double n[3], length, whole;
        for (k = 0; k < 3; k++) {
            c[k] = pbwsf__corner(&w->surface, (pbw_index)at, k);
        }
        pbwsf__normal(c[0], c[1], c[2], n);
        length = sqrt(pbwsf__dot(n, n));
        pbwm3__plane_of(w, (pbw_index)at, n);
        whole = sqrt(pbwsf__dot(n, n));
        for (k = 0; k < 3 && length > 0 && whole > 0; k++) {
            n[k] *= (queue[done] % 2 ? -1 : 1) * fmin(length, w->size * w->size) / whole;
            sum[k] += n[k];
        }
        area += length / 2;
        if (flat && length > 0 && !pbwim__turned_less(sum, n, 0.99996192306417129)) {        /* cos 0.5 degrees */
            return 0;
        }
        for (k = 0; k < 3 && count < most; k++) {
            const size_t next = across[3 * at + (size_t)k], u = next / 2;
            double nearby[3], third[3];
            if (next == (size_t)-1 || seen[u] == f->floods) {
                continue;
            }
            seen[u] = f->floods;
            for (j = 0; j < 3; j++) {
                c[j] = pbwsf__corner(&w->surface, (pbw_index)u, j);
            }
            for (j = 0; j < 3; j++) {
                third[j] = (c[0][j] + c[1][j] + c[2][j]) / 3 - middle[j];
            }
            pbwsf__nearest_in(c[0], c[1], c[2], middle, nearby);
            if (pbwsf__distance(nearby, middle) < within && pbwsf__dot(third, side) > 0) {
                queue[count++] = 2 * u + (next ^ queue[done]) % 2;
            }
        }
    }
    return flat && area > 1.57 * within * within;
}

/* Returns whether an edge is sharp at the scale of the size: the mean normals on its two sides, within a size of its
   middle, differ by more than 52 degrees; or both sides are flat for three sizes.  The angle between such normals
   falls with the scale on a smooth surface, but not between two planes. */
static int pbwm3__is_sharp_at_scale(const pbwm3__work *w, pbwm3__features *f, const pbwim__facet *edge)
{
    const double *a = w->surface.points + 3 * (size_t)edge[0].v[0], *b = w->surface.points + 3 * (size_t)edge[0].v[1];
    double middle[3], along[3], n[2][3], mean[3], side[3], plane[2][2][3], sum[2][3];
    int i, k;
    pbwsf__between(a, b, 0.5, middle);
    pbwsf__minus(b, a, along);
    for (i = 0; i < 2; i++) {
        const pbw_index t = edge[i].t;
        double length;
        pbwm3__plane_of(w, t, n[i]);
        length = sqrt(pbwsf__dot(n[i], n[i]));
        for (k = 0; k < 3; k++) {
            n[i][k] *= (i == 1 && edge[0].v[2] == edge[1].v[2] ? -1 : 1) / (length > 0 ? length : 1);
        }
    }
    for (k = 0; k < 3; k++) {
        mean[k] = n[0][k] + n[1][k];
    }
    pbwsf__cross(mean, along, side);
    for (i = 0; i < 2; i++) {
        const double *c = pbwsf__corner(&w->surface, edge[i].t, (edge[i].i + 2) % 3);
        double out[3];
        pbwsf__minus(c, middle, out);
        for (k = 0; k < 3; k++) {
            plane[i][0][k] = middle[k];
            plane[i][1][k] = pbwsf__dot(out, side) < 0 ? -side[k] : side[k];
        }
        pbwm3__mean_normal(w, f, edge[i].t, (const double (*)[3])plane[i], 0, sum[i]);
        for (k = 0; k < 3 && i == 1 && edge[0].v[2] == edge[1].v[2]; k++) {
            sum[1][k] = -sum[1][k];
        }
    }
    return !pbwim__turned_less(sum[0], sum[1], 0.61566147532565829)          /* cos 52 degrees */
        || (pbwm3__mean_normal(w, f, edge[0].t, (const double (*)[3])plane[0], 1, sum[0])
            && pbwm3__mean_normal(w, f, edge[1].t, (const double (*)[3])plane[1], 1, sum[1]));
}

/* Drops branches shorter than three sizes, from a loose end to where edges meet.  Returns how many edges. */
static size_t pbwm3__drop_spurs(const pbwm3__work *w, pbwm3__features *f)
{
    const pbwm3__graph *g = &f->graph;
    const size_t *first = g->first.at, *at = g->at.at;
    size_t *degree = f->degree.at, *branch = f->branch.at, v, i, dropped = 0;
    unsigned char *gone = g->used.at;
    for (v = 0; v < w->surface.point_count; v++) {
        pbw_index end = (pbw_index)v;
        double length = 0;
        size_t count = 0;
        while (degree[end] == (count == 0 ? 1 : 2) && length < 3 * w->size) {
            for (i = first[end]; gone[at[i]] || (count > 0 && at[i] == branch[count - 1]); i++) {
            }
            length += at[i] < f->fixed ? HUGE_VAL
                    : pbwsf__distance(w->surface.points + 3 * (size_t)g->ends[at[i]][0],
                                      w->surface.points + 3 * (size_t)g->ends[at[i]][1]);
            branch[count++] = at[i];
            end = pbwm3__other_end(g, at[i], end);
        }
        for (i = 0; i < count && degree[end] > 2 && length < 3 * w->size; i++) {
            gone[branch[i]] = 1;
            degree[g->ends[branch[i]][0]]--;
            degree[g->ends[branch[i]][1]]--;
            dropped++;
        }
    }
    return dropped;
}

/* Finds the connected parts of the edges that are not marked `used`: trees of their vertices, and at each root the
   length of the part, infinite if it has one of the first `fixed` edges. */
static int pbwm3__measure_parts(pbwm3__work *w, const pbwm3__graph *g, size_t fixed, pbwsf__counts *parents,
                                pbwsf__numbers *lengths)
{
    const size_t points = w->surface.point_count;
    size_t i;
    if (!pbwm3__start_trees(&w->memory, parents, points) || !PBW_ZEROS(&w->memory, *lengths, points)) {
        return 0;
    }
    for (i = 0; i < g->count; i++) {
        if (g->used.at == NULL || !g->used.at[i]) {
            pbwm3__join(parents->at, g->ends[i][0], g->ends[i][1]);
        }
    }
    for (i = 0; i < g->count; i++) {
        if (g->used.at == NULL || !g->used.at[i]) {
            lengths->at[pbwm3__root_of(parents->at, g->ends[i][0])] += i < fixed ? HUGE_VAL : pbwsf__distance(
                w->surface.points + 3 * (size_t)g->ends[i][0], w->surface.points + 3 * (size_t)g->ends[i][1]);
        }
    }
    return 1;
}

/* Drops connected edges that are shorter together than eight sizes if an end of them is loose, else than four. */
static int pbwm3__drop_parts(pbwm3__work *w, pbwm3__features *f)
{
    const pbwm3__graph *g = &f->graph;
    pbwsf__counts parents = { NULL, 0, 0 };
    pbwsf__numbers lengths = { NULL, 0, 0 };
    size_t i;
    const int good = pbwm3__measure_parts(w, g, f->fixed, &parents, &lengths);
    for (i = 0; good && i < w->surface.point_count; i++) {
        const size_t root = pbwm3__root_of(parents.at, i);
        if (f->degree.at[i] == 1 && lengths.at[root] < 8 * w->size) {
            lengths.at[root] = 0;
        }
    }
    for (i = f->fixed; good && i < g->count; i++) {
        g->used.at[i] |= lengths.at[pbwm3__root_of(parents.at, g->ends[i][0])] < 4 * w->size;
    }
    PBW_RELEASE(&w->memory, parents);
    PBW_RELEASE(&w->memory, lengths);
    return good;
}

/* Sets keeps[i] to 1 for the candidates that are features; fixed: the edges that are always kept. */
static int pbwm3__find_features(pbwm3__work *w, pbwm3__features *f, const pbwsf__pairs *fixed)
{
    const size_t *candidate = f->candidates.at;
    unsigned char *keeps = f->keeps.at;
    size_t i, at;
    int good = pbwm3__find_across(w, f);
    for (i = 0; good && i < fixed->count; i++) {
        good = PBWM3__APPEND(w, f->ends, fixed->at[i]);
    }
    f->fixed = fixed->count;
    for (i = 0; good && i < f->candidates.count && !pbwm3__ends_at(w, i, 256); i++) {
        keeps[i] = (unsigned char)pbwm3__is_sharp_at_scale(w, f, f->edge + candidate[i]);
        good = !keeps[i] || PBWM3__APPEND(w, f->ends, f->edge[candidate[i]].v);
    }
    f->graph.ends = f->ends.at;
    f->graph.count = f->ends.count;
    good = good && !pbwm3__has_ended(w) && pbwm3__make_graph(w, &f->graph)
        && PBW_FIT(&w->memory, f->degree, w->surface.point_count + 1)
        && PBW_FIT(&w->memory, f->branch, f->ends.count + 1);
    for (i = 0; good && i < w->surface.point_count; i++) {
        const size_t *first = f->graph.first.at;
        f->degree.at[i] = first[i + 1] - first[i];
    }
    for (i = 0; good && i < 8 && pbwm3__drop_spurs(w, f) > 0; i++) {
    }
    good = good && pbwm3__drop_parts(w, f);
    for (i = 0, at = f->fixed; good && i < f->candidates.count; i++) {
        keeps[i] = (unsigned char)(keeps[i] && !f->graph.used.at[at++]);
    }
    return good;
}

/* Returns whether shells cross at an edge. */
static int pbwm3__is_cut(const pbwm3__work *w, const pbw_index *edge)
{
    const uint64_t key = pbwm3__edge_key(edge[0], edge[1]);
    size_t low = 0, high = w->cuts.count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        const int below = pbwm3__edge_key(w->cuts.at[middle][0], w->cuts.at[middle][1]) < key;
        *(below ? &low : &high) = below ? middle + 1 : middle;
    }
    return low < w->cuts.count && pbwm3__edge_key(w->cuts.at[low][0], w->cuts.at[low][1]) == key;
}

/* Chooses which of the candidates are kept; fixed: the edges that are always kept, two points each. */
static int pbwm3__choose_sharp(pbwm3__work *w, pbwm3__features *f, const pbwsf__pairs *fixed)
{
    size_t i, kept = 0, counted = 0;
    int good = PBW_FIT(&w->memory, f->keeps, f->candidates.count + 1), sharp = w->sharp;
    if (good && f->candidates.count > 0 && (sharp == PBW_SOLID_SHARP_AUTO || sharp == PBW_SOLID_SHARP_SOME)) {
        good = pbwm3__find_features(w, f, fixed);
        for (i = 0; good && i < f->candidates.count; i++) {      /* those where shells cross say nothing of these */
            const int cut = pbwm3__is_cut(w, f->edge[f->candidates.at[i]].v);
            kept += !cut && f->keeps.at[i];
            counted += !cut;
        }
        w->report->sharp_share = counted > 0 ? (double)kept / (double)counted : -1;
    }
    if (sharp == PBW_SOLID_SHARP_AUTO) {
        sharp = w->report->sharp_share < 0 || w->report->sharp_share >= 0.85 ? PBW_SOLID_SHARP_ALL
              : w->report->sharp_share > 1.0 / 3 ? PBW_SOLID_SHARP_SOME : PBW_SOLID_SHARP_NONE;
    }
    if (good && sharp != PBW_SOLID_SHARP_SOME) {
        memset(f->keeps.at, sharp == PBW_SOLID_SHARP_ALL, f->candidates.count + 1);
    }
    w->report->sharp = sharp;
    PBW_RELEASE(&w->memory, f->across);
    PBW_RELEASE(&w->memory, f->seen);
    PBW_RELEASE(&w->memory, f->ends);
    PBW_RELEASE(&w->memory, f->degree);
    PBW_RELEASE(&w->memory, f->branch);
    PBW_RELEASE(&w->memory, f->graph.first);
    PBW_RELEASE(&w->memory, f->graph.at);
    PBW_RELEASE(&w->memory, f->graph.used);
    return good;
}

/* ------------------------------------------------------------------------------------------------------
   >>chains       Sharp edges chained between corners, and the patches that they bound.
   In: the surface.  Out: `chains` of the sharp edges that are kept; per triangle its part and its patch; sets of the
   patches that meet at edges and corners.
   ------------------------------------------------------------------------------------------------------ */

/* Returns whether the normals of an edge's two triangles differ by more than the feature angle; 0 if one has no
   area. */
static int pbwm3__is_sharp(const pbwm3__work *w, const pbwim__facet *edge)
{
    double n[2][3];
    int i, k;
    for (i = 0; i < 2; i++) {
        const pbw_index t = edge[i].t;
        pbwm3__plane_of(w, t, n[i]);
        for (k = 0; k < 3 && i == 1 && edge[0].v[2] == edge[1].v[2]; k++) {          /* turned the other way */
            n[1][k] = -n[1][k];
        }
    }
    return pbwsf__dot(n[0], n[0]) > 0 && pbwsf__dot(n[1], n[1]) > 0 && !pbwim__turned_less(n[0], n[1], w->cosine);
}

/* The least angle, in degrees, between two of the first triangles of an edge, 16 at most. */
static double pbwm3__angle_at(const pbwm3__work *w, const pbwim__facet *edge, size_t count)
{
    double n[16][3], across[3], least = HUGE_VAL;
    size_t i, k;
    for (i = 0; i < count && i < 16; i++) {
        pbwm3__plane_of(w, edge[i].t, n[i]);
        for (k = 0; k < 3 && !edge[i].v[2]; k++) {   /* as if all turned the edge the same way */
            n[i][k] = -n[i][k];
        }
        for (k = 0; k < i; k++) {
            pbwsf__cross(n[k], n[i], across);
            least = fmin(least, atan2(sqrt(pbwsf__dot(across, across)), pbwsf__dot(n[k], n[i])));
        }
    }
    return least * 57.295779513082321;
}

/* Numbers the parts, whose roots are in `parent`, and the patches.  An open surface is one patch, as sharp edges of a
   scan are noise. */
static int pbwm3__number_patches(pbwm3__work *w, size_t *parent)
{
    pbw_index *patch = w->patch.at, *part = w->part.at, parts = 0;
    size_t t;
    for (t = 0; t < w->surface.triangle_count; t++) {            /* a root is the least of its tree */
        const size_t root = pbwm3__root_of(parent, t);
        part[t] = root == t ? parts++ : part[root];
    }
    for (t = 0; (w->open || w->whole) && t < w->surface.triangle_count; t++) {
        parent[t] = 0;
    }
    for (t = 0; t < w->surface.triangle_count; t++) {
        if (pbwm3__root_of(parent, t) == t) {
            const pbw_index number = (pbw_index)w->patch_count++;
            pbwm3__set set;
            set.first = w->members.count;
            set.count = 1;
            patch[t] = number;
            const pbw_index first = (pbw_index)t;
            if (!PBW_PUSH(&w->memory, w->members, number)
                || !PBW_PUSH(&w->memory, w->firsts, first)
                || !PBW_PUSH(&w->memory, w->sets, set)) {
                return 0;
            }
        }
    }
    for (t = 0; t < w->surface.triangle_count; t++) {
        patch[t] = patch[pbwm3__root_of(parent, t)];
    }
    return 1;
}

/* The caller's patch of a triangle, 0 if there are none, PBW_NONE of one that closes a hole. */
static pbw_index pbwm3__patch_of(const pbwm3__work *w, pbw_index triangle)
{
    return w->input->value != NULL ? 0 : triangle >= w->first_closing ? PBW_NONE
         : w->input->patches != NULL ? w->input->patches[w->origin.at[triangle]] : 0;
}

/* Returns whether an edge is between two of the caller's patches. */
static int pbwm3__has_border(const pbwm3__work *w, const pbwim__facet *edge)
{
    const pbw_index a = pbwm3__patch_of(w, edge[0].t), b = pbwm3__patch_of(w, edge[1].t);
    return a != b && a != PBW_NONE && b != PBW_NONE;
}

/* Keeps a sharp edge in the list, two points each. */
static int pbwm3__keep_sharp(pbwm3__work *w, const pbwim__facet *edge, size_t count, pbwsf__pairs *list)
{
    const double angle = pbwm3__angle_at(w, edge, count);
    w->report->least_angle = fmin(w->report->least_angle, angle);
    w->report->acute_edges += angle < 60;
    return PBWM3__APPEND(w, *list, edge->v);
}

/* Lists the sharp edges that are kept, and joins the triangles at all others.  Which candidates are kept is chosen
   once all of them are found.  A function has none: where its surface has two triangles at each edge, the shells are
   the parts. */
static int pbwm3__find_sharp(pbwm3__work *w, pbwsf__pairs *list, size_t *parent)
{
    const size_t triangles = w->surface.triangle_count;
    const int plain = w->input->value != NULL && w->report->open_edges + w->report->crowded_edges == 0;
    const size_t count = plain ? 0 : 3 * triangles;
    pbwim__sorting sorting;
    pbwm3__features f;
    const pbwim__facet *edge;
    size_t i, k, edges = plain ? 3 * triangles / 2 : 0;
    int good;
    memset(&sorting, 0, sizeof sorting);
    edge = plain ? NULL : pbwm3__edges(w, w->surface.triangles, triangles, w->surface.point_count, &sorting);
    good = plain || edge != NULL;
    memset(&f, 0, sizeof f);
    f.edge = edge;
    for (i = 0; i < triangles && plain; i++) {
        parent[i] = w->shells.at[w->shell.at[i]].triangle;
    }
    for (i = 0; good && i < count; i = k) {
        for (k = i + 1; k < count && memcmp(edge[i].v, edge[k].v, 2 * sizeof(pbw_index)) == 0; k++) {
        }
        edges++;
        if (w->input->value == NULL && ((k - i > 2 && edge[k - 1].t < w->first_closing)
                                        || (k - i == 2 && pbwm3__has_border(w, edge + i)))) {
            good = pbwm3__keep_sharp(w, edge + i, k - i, list);
        } else if (w->input->value == NULL && k - i == 2 && pbwm3__is_sharp(w, edge + i)
                   && (edge[i].t < w->first_closing || edge[i + 1].t < w->first_closing)) {
            good = PBW_PUSH(&w->memory, f.candidates, i);
        } else if (k - i == 2) {
            pbwm3__join(parent, edge[i].t, edge[i + 1].t);
        }
    }
    good = good && pbwm3__choose_sharp(w, &f, list);
    for (i = 0; good && i < f.candidates.count; i++) {
        k = f.candidates.at[i];
        if (f.keeps.at[i]) {
            good = pbwm3__keep_sharp(w, edge + k, 2, list);
        } else {
            pbwm3__join(parent, edge[k].t, edge[k + 1].t);
        }
    }
    PBW_RELEASE(&w->memory, f.candidates);
    PBW_RELEASE(&w->memory, f.keeps);
    w->report->sharp_edges = list->count;
    if (!w->walls) {
        w->report->input_euler = (long)w->surface.point_count - (long)edges + (long)triangles;
    }
    pbwim__end_sorting(&w->memory, &sorting);
    return good;
}

/* Returns whether chains end at v: it has not two edges, or they form an angle.  On open surfaces, which are scans,
   angles are noise. */
static int pbwm3__is_corner(const pbwm3__work *w, const pbwm3__graph *g, pbw_index v)
{
    const size_t *first = g->first.at, *at = g->at.at;
    double a[3], b[3];
    if (first[v + 1] - first[v] != 2 || w->open) {
        return first[v + 1] - first[v] != 2 && first[v + 1] > first[v];
    }
    pbwsf__minus(w->surface.points + 3 * (size_t)v,
                 w->surface.points + 3 * (size_t)pbwm3__other_end(g, at[first[v]], v), a);
    pbwsf__minus(w->surface.points + 3 * (size_t)pbwm3__other_end(g, at[first[v] + 1], v),
                 w->surface.points + 3 * (size_t)v, b);
    return !pbwim__turned_less(a, b, w->cosine);
}

/* Walks from v along unused edges to a corner, or back to v. */
static int pbwm3__walk_chain(pbwm3__work *w, pbwm3__graph *g, pbw_index v, size_t edge)
{
    const size_t *first = g->first.at, *at = g->at.at;
    unsigned char *used = g->used.at;
    const pbw_index start = v;
    pbwm3__chain chain;
    pbwm3__chain_vertex item;
    item.vertex = v;
    item.along = 0;
    chain.first = w->path.count;
    chain.count = 1;
    if (!PBW_PUSH(&w->memory, w->path, item)) {
        return 0;
    }
    for (;;) {
        const pbw_index next = pbwm3__other_end(g, edge, v);
        used[edge] = 1;
        item.along += pbwsf__distance(w->surface.points + 3 * (size_t)v, w->surface.points + 3 * (size_t)next);
        item.vertex = next;
        chain.count++;
        if (!PBW_PUSH(&w->memory, w->path, item)) {
            return 0;
        }
        v = next;
        if (v == start || pbwm3__is_corner(w, g, v)) {
            break;
        }
        edge = used[at[first[v]]] ? at[first[v] + 1] : at[first[v]];
    }
    chain.closed = v == start;
    chain.loose = first[v + 1] - first[v] == 1 || first[start + 1] - first[start] == 1;
    return PBW_PUSH(&w->memory, w->chains, chain);
}

/* ---- patches at sharp edges and corners ---- */

typedef struct pbwm3__stars { pbwsf__counts first, at; } pbwm3__stars;    /* triangles at vertex v: as in the graph */

/* Lists the triangles that have each vertex as a corner. */
static int pbwm3__make_stars(pbwm3__work *w, pbwm3__stars *stars)
{
    const size_t points = w->surface.point_count, count = 3 * w->surface.triangle_count;
    size_t *first, i;
    if (!PBW_FIT(&w->memory, stars->first, points + 2)
        || !PBW_FIT(&w->memory, stars->at, count + 1)) {
        return 0;
    }
    first = stars->first.at;
    memset(first, 0, (points + 2) * sizeof *first);
    for (i = 0; i < count; i++) {
        first[w->surface.triangles[i] + 2]++;
    }
    for (i = 0; i < points; i++) {
        first[i + 2] += first[i + 1];
    }
    for (i = 0; i < count; i++) {
        stars->at.at[first[w->surface.triangles[i] + 1]++] = i / 3;
    }
    return 1;
}

static void pbwm3__free_stars(pbwm3__work *w, pbwm3__stars *stars)
{
    PBW_RELEASE(&w->memory, stars->first);
    PBW_RELEASE(&w->memory, stars->at);
}

static int pbwm3__is_at(const pbwm3__stars *stars, pbw_index v, size_t triangle)
{
    size_t i = stars->first.at[v];
    while (i < stars->first.at[v + 1] && stars->at.at[i] != triangle) {
        i++;
    }
    return i < stars->first.at[v + 1];
}

/* Returns the number of a new set, of the patches of the triangles with corners u and v, which may be one vertex;
   (size_t)-1 if there is no memory. */
static size_t pbwm3__set_at(pbwm3__work *w, const pbwm3__stars *stars, pbw_index u, pbw_index v)
{
    const size_t *first = stars->first.at, *at = stars->at.at;
    pbwm3__set set;
    size_t i, k;
    set.first = w->members.count;
    set.count = 0;
    for (i = first[u]; i < first[u + 1]; i++) {
        const pbw_index patch = w->patch.at[at[i]];
        const pbw_index *member = w->members.at + set.first;
        for (k = 0; k < set.count && member[k] != patch; k++) {
        }
        if (k == set.count && (u == v || pbwm3__is_at(stars, v, at[i]))) {
            if (!PBW_PUSH(&w->memory, w->members, patch)) {
                return (size_t)-1;
            }
            set.count++;
        }
    }
    return PBW_PUSH(&w->memory, w->sets, set) ? w->sets.count - 1 : (size_t)-1;
}

static int pbwm3__set_has(const pbwm3__work *w, pbw_index point, pbw_index patch)
{
    const pbwm3__set set = w->sets.at[w->set.at[point]];
    const pbw_index *member = w->members.at + set.first;
    size_t i;
    for (i = 0; i < set.count && member[i] != patch; i++) {
    }
    return i < set.count;
}

/* Returns the least patch that all of these points of the surface are on, or PBW_NONE. */
static pbw_index pbwm3__common_patch(const pbwm3__work *w, const pbw_index *c, int count)
{
    const pbwm3__set set = w->sets.at[w->set.at[c[0]]];
    pbw_index best = PBW_NONE;
    size_t i;
    int k;
    for (i = 0; i < set.count; i++) {
        const pbw_index patch = w->members.at[set.first + i];
        for (k = 1; k < count && pbwm3__set_has(w, c[k], patch); k++) {
        }
        best = k == count && patch < best ? patch : best;
    }
    return best;
}

/* The point of a chain that far along it. */
static void pbwm3__along(const pbwm3__work *w, size_t number, double along, double out[3])
{
    const pbwm3__chain *chain = w->chains.at + number;
    const pbwm3__chain_vertex *path = w->path.at + chain->first;
    size_t low = 0, high = chain->count - 1;
    double length;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        *(path[middle].along <= along ? &low : &high) = middle;
    }
    length = path[high].along - path[low].along;
    pbwsf__between(w->surface.points + 3 * (size_t)path[low].vertex,
                   w->surface.points + 3 * (size_t)path[high].vertex,
                   length > 0 ? (along - path[low].along) / length : 0, out);
}

/* All chains, those from corners first, then closed ones without a corner. */
static int pbwm3__chain_all(pbwm3__work *w, pbwm3__graph *g)
{
    const size_t *first, *at;
    size_t v, i;
    int loops;
    if (!pbwm3__make_graph(w, g)) {
        return 0;
    }
    first = g->first.at;
    at = g->at.at;
    for (loops = 0; loops < 2; loops++) {
        for (v = 0; v < w->surface.point_count; v++) {
            const int corner = pbwm3__is_corner(w, g, (pbw_index)v);
            w->report->corners += corner && !loops;
            for (i = first[v]; (corner || loops) && i < first[v + 1]; i++) {
                if (!g->used.at[at[i]] && !pbwm3__walk_chain(w, g, (pbw_index)v, at[i])) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Finds sharp edges and patches. */
static int pbwm3__find_patches(pbwm3__work *w, pbwsf__pairs *list)
{
    pbwsf__counts parents = { NULL, 0, 0 };
    const size_t count = w->surface.triangle_count;
    const int good = pbwm3__start_trees(&w->memory, &parents, count) && PBW_FIT(&w->memory, w->part, count)
        && PBW_FIT(&w->memory, w->patch, count) && pbwm3__find_sharp(w, list, parents.at)
        && pbwm3__number_patches(w, parents.at);
    PBW_RELEASE(&w->memory, parents);
    return good;
}

/* Drops connected sharp edges of an open surface that are shorter than four sizes together: noise of a scan. */
static int pbwm3__drop_noise(pbwm3__work *w, pbwsf__pairs *list)
{
    pbwsf__counts parents = { NULL, 0, 0 };
    pbwsf__numbers lengths = { NULL, 0, 0 };
    pbwm3__graph graph;
    size_t i, kept = 0;
    int good;
    memset(&graph, 0, sizeof graph);
    graph.ends = list->at;
    graph.count = list->count;
    good = pbwm3__measure_parts(w, &graph, 0, &parents, &lengths);
    for (i = 0; good && i < list->count; i++) {
        if (lengths.at[pbwm3__root_of(parents.at, list->at[i][0])] > 4 * w->size) {
            memmove(list->at[kept++], list->at[i], sizeof *list->at);
        }
    }
    list->count = good ? kept : list->count;
    PBW_RELEASE(&w->memory, parents);
    PBW_RELEASE(&w->memory, lengths);
    return good;
}

/* Finds patches, sharp edges and their chains. */
static pbw_status pbwm3__find_chains(pbwm3__work *w)
{
    pbwsf__pairs list = { NULL, 0, 0 };
    pbwm3__graph graph;
    int good;
    memset(&graph, 0, sizeof graph);
    good = pbwm3__find_patches(w, &list) && (!w->open || pbwm3__drop_noise(w, &list));
    graph.ends = list.at;
    graph.count = list.count;
    good = good && pbwm3__chain_all(w, &graph);
    PBW_RELEASE(&w->memory, list);
    PBW_RELEASE(&w->memory, graph.first);
    PBW_RELEASE(&w->memory, graph.at);
    PBW_RELEASE(&w->memory, graph.used);
    return pbwm3__has_ended(w) ? PBW_CANCELLED : good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Number i of a stream, from 0 to 1. */
static double pbwm3__random(uint64_t i)
{
    return (double)(pbw_random(0, i) >> 11) / 9007199254740992.0;
}

/* ------------------------------------------------------------------------------------------------------
   >>sizes        Local sizes.
   In: the surface, chains, the caller's sizes.  Out: `field`, a size per cell, the least of
     - the size, the caller's at the place, and that of its region;
     - three quarters of the distance between two sheets of the surface that face each other, or four thirds of it
       below 0.4 sizes;
     - two thirds of the distance between sharp chains without a common corner;
     - a multiple of the radius of curvature.
   Holds: no size is below the floor; sizes grow by at most the gradation for each unit of length.
   ------------------------------------------------------------------------------------------------------ */

/* Lowers the field at p to a size, but not below the floor. */
static void pbwm3__lower(pbwm3__work *w, const double p[3], double size)
{
    double *field = w->field.at + pbwm3__field_cell(w, p);
    *field = fmin(*field, fmax(w->floor, size));
}

/* Returns what the size between two triangles is not below, at a place between them: less where two shells would grow
   together. */
static double pbwm3__gap_floor(const pbwm3__work *w, pbw_index a, pbw_index b, const double between[3])
{
    const int apart = w->gap_floor < w->floor && w->shell.at[a] != w->shell.at[b] && pbwm3__inside(w, between) == 0;
    return apart ? w->gap_floor : w->floor;
}

/* The size that the caller gives the region at p, infinite if none. */
static double pbwm3__region_size(const pbwm3__work *w, const double p[3])
{
    const size_t count = w->how.region_sizes != NULL ? w->how.region_size_count : 0;
    const pbw_index region = count > 0 ? pbwm3__shells_around(w, p, (size_t)-1).innermost : PBW_NONE;
    return region != PBW_NONE && region < count && w->how.region_sizes[region] > 0
         ? fmax(w->how.region_sizes[region], w->how.least_size) : HUGE_VAL;
}

/* Returns the size at p, a point of the triangle: those of the regions on both sides; and from the first triangles
   that rays along both normals meet, if these face it: both planes meet farther away than 1.5 sizes, so that acute
   edges are no walls.  Walls below 0.4 sizes get one layer of tetrahedra: edges between half and the whole of their
   thickness make flat ones. */
static double pbwm3__measure_gap(const pbwm3__work *w, pbw_index triangle, const double p[3])
{
    double n[3], m[3], a[3], b[3], across[3], where, gap, length, least = HUGE_VAL;
    int side, k;
    pbwsf__normal_of(&w->surface, triangle, n);
    length = sqrt(pbwsf__dot(n, n));
    for (side = -1; side <= 1 && length > 0; side += 2) {
        pbw_index met;
        for (k = 0; k < 3; k++) {
            a[k] = p[k] + side * 1e-3 * w->size * n[k] / length;
            b[k] = p[k] + side * 1.4 * w->size * n[k] / length;
        }
        least = fmin(least, pbwm3__region_size(w, a));
        met = pbw_surface_meets(&w->surface, a, b, &where);
        gap = where * 1.399 + 1e-3;
        if (met != PBW_NONE) {
            pbwsf__normal_of(&w->surface, met, m);
            pbwsf__cross(n, m, across);
            if (gap * fabs(pbwsf__dot(m, n)) > 1.5 * sqrt(pbwsf__dot(across, across))) {
                pbwsf__between(p, a, 500 * gap, b);  /* a is 1/1000 of the size away */
                least = fmin(least, fmax((gap < 0.4 ? 1.33 : 0.75) * gap * w->size,
                                         pbwm3__gap_floor(w, triangle, met, b)));
            }
        }
    }
    return least;
}

/* Four sweeps there and back, or until nothing changes: a cell is above its neighbours by at most the gradation. */
static void pbwm3__grade(pbwm3__work *w)
{
    double *field = w->field.at;
    const double growth = (w->how.gradation > 0 ? w->how.gradation : 0.35) * w->size;
    const size_t total = w->n[0] * w->n[1] * w->n[2];
    size_t i, j;
    int sweep, k, changed = 1;
    for (sweep = 0; sweep < 8 && changed && !pbwm3__has_ended(w); sweep++) {
        changed = 0;
        for (j = 0; j < total && !pbwm3__ends_at(w, j, 65536); j++) {
            i = sweep % 2 == 0 ? j : total - 1 - j;
            for (k = 0; k < 27; k++) {
                const size_t x = i % w->n[0] + (size_t)(k % 3), y = i / w->n[0] % w->n[1] + (size_t)(k / 3 % 3);
                const size_t z = i / w->n[0] / w->n[1] + (size_t)(k / 9);
                if (x > 0 && x <= w->n[0] && y > 0 && y <= w->n[1] && z > 0 && z <= w->n[2]) {
                    const double other = field[x - 1 + w->n[0] * (y - 1 + w->n[1] * (z - 1))] + growth;
                    if (other < field[i]) {
                        field[i] = other;
                        changed = 1;
                    }
                }
            }
        }
    }
}

typedef struct pbwm3__curvature { double area, tensor[6]; } pbwm3__curvature;  /* sums over a cell of the field */

/* Adds parts of a triangle's area, of at most half a size, to the cells that they are in, unless cell is NULL, and
   their number to *spread.  Returns its area in squares of the local sizes. */
static double pbwm3__spread_area(const pbwm3__work *w, pbw_index t, pbwm3__curvature *cell, size_t *spread)
{
    const double *c[3];
    double n[3], longest = 0, p[3], size, squares = 0;
    size_t parts, i, j;
    int k;
    for (k = 0; k < 3; k++) {
        c[k] = pbwsf__corner(&w->surface, t, k);
        longest = fmax(longest, pbwsf__distance(c[k], pbwsf__corner(&w->surface, t, (k + 1) % 3)));
    }
    pbwsf__normal(c[0], c[1], c[2], n);
    parts = (size_t)fmin(ceil(2 * longest / w->size), 1000) + 1;
    for (i = 0; i < parts; i++) {
        for (j = 0; j < 2 * i + 1; j++) {            /* row i of small triangles, every second one upside down */
            const double u = ((double)i + (j % 2 == 0 ? 2.0 / 3 : 1.0 / 3)) / (double)parts;
            const double v = ((double)(j / 2) + (j % 2 == 0 ? 1.0 / 3 : 2.0 / 3)) / (double)parts;
            for (k = 0; k < 3; k++) {
                p[k] = c[0][k] + u * (c[1][k] - c[0][k]) + v * (c[2][k] - c[1][k]);
            }
            if (cell != NULL) {
                cell[pbwm3__field_cell(w, p)].area += 0.5 * sqrt(pbwsf__dot(n, n)) / (double)(parts * parts);
            }
            size = pbwm3__size(w, p);
            squares += 0.5 * sqrt(pbwsf__dot(n, n)) / (double)(parts * parts) / (size * size);
        }
    }
    *spread += parts * parts;
    return squares;
}

/* Adds the curvature tensor of an edge to the cells along it. */
static void pbwm3__spread_curvature(const pbwm3__work *w, const pbwim__facet *edge, pbwm3__curvature *cell)
{
    static const int pair[6][2] = { { 0, 0 }, { 1, 1 }, { 2, 2 }, { 0, 1 }, { 0, 2 }, { 1, 2 } };
    const double *a = w->surface.points + 3 * (size_t)edge[0].v[0], *b = w->surface.points + 3 * (size_t)edge[0].v[1];
    double n[2][3], across[3], along[3], p[3], bend, length = pbwsf__distance(a, b);
    const size_t parts = (size_t)fmin(ceil(2 * length / w->size), 1e6);
    size_t i;
    int k;
    for (k = 0; k < 2; k++) {                        /* turned alike: edge 0 runs from a to b in one of them */
        pbwsf__normal(pbwsf__corner(&w->surface, edge[k].t, 0), pbwsf__corner(&w->surface, edge[k].t, 1),
                      pbwsf__corner(&w->surface, edge[k].t, 2), n[k]);
    }
    pbwsf__cross(n[0], n[1], across);
    pbwsf__minus(b, a, along);
    bend = atan2(pbwsf__dot(across, along) / (length > 0 ? length : 1), pbwsf__dot(n[0], n[1]));
    bend *= edge[0].v[2] ? 1 : -1;
    for (i = 0; i < parts && length > 0; i++) {
        pbwsf__between(a, b, ((double)i + 0.5) / (double)parts, p);
        for (k = 0; k < 6; k++) {
            cell[pbwm3__field_cell(w, p)].tensor[k] += bend * along[pair[k][0]] * along[pair[k][1]] / length
                                                      / (double)parts;
        }
    }
}

/* Lowers the field where the surface is curved, by the tensor of Cohen-Steiner and Morvan (2003, "Restricted Delaunay
   triangulations and normal cycle").  Its norm, divided by the area of the cell, is the root of the sum of both
   principal curvatures' squares. */
static int pbwm3__measure_curvature(pbwm3__work *w)
{
    pbwim__sorting sorting;
    PBW_ARRAY(pbwm3__curvature) sums = { NULL, 0, 0 };
    const size_t count = 3 * w->surface.triangle_count, total = w->n[0] * w->n[1] * w->n[2];
    const pbwim__facet *edge = pbwm3__edges(w, w->surface.triangles, w->surface.triangle_count,
                                            w->surface.point_count, &sorting);
    pbwm3__curvature *cell;
    size_t i, k, spread = 0;
    int good;
    good = edge != NULL && PBW_FIT(&w->memory, sums, total);
    cell = sums.at;
    if (good) {
        memset(cell, 0, total * sizeof *cell);
    }
    for (i = 0; good && i < w->surface.triangle_count && !pbwm3__has_ended(w); i++) {
        (void)pbwm3__spread_area(w, (pbw_index)i, cell, &spread);
        if (spread > 16384) {
            spread = 0;
            (void)pbwm3__ends(w);
        }
    }
    for (i = 0; good && i < count; i = k) {
        for (k = i + 1; k < count && memcmp(edge[i].v, edge[k].v, 2 * sizeof(pbw_index)) == 0; k++) {
        }
        if (k - i == 2 && (w->input->value != NULL || !pbwm3__is_sharp(w, edge + i))) {
            pbwm3__spread_curvature(w, edge + i, cell);
        }
    }
    for (i = 0; good && i < total; i++) {
        const double *t = cell[i].tensor;
        const double norm = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]
                                 + 2 * (t[3] * t[3] + t[4] * t[4] + t[5] * t[5]));
        if (norm > 0 && cell[i].area > 0.1 * w->size * w->size) {
            double *size = w->field.at + i;
            *size = fmin(*size, fmax(w->floor, w->how.curvature * cell[i].area / norm));
        }
    }
    pbwim__end_sorting(&w->memory, &sorting);
    PBW_RELEASE(&w->memory, sums);
    return good;
}

typedef struct pbwm3__probe { double p[3]; size_t chain; pbw_index next; } pbwm3__probe;  /* next: in its cell */
typedef PBW_ARRAY(pbwm3__probe) pbwm3__probes;

/* Probes on all chains, a quarter of the size apart, in lists by cells of the field. */
static int pbwm3__probe_chains(pbwm3__work *w, pbwm3__probes *probes, pbw_index *head)
{
    size_t i;
    for (i = 0; i < w->chains.count; i++) {
        const pbwm3__chain *chain = w->chains.at + i;
        const double length = w->path.at[chain->first + chain->count - 1].along;
        const size_t most = chain->loose ? 0 : (size_t)ceil(fmin(4 * length / w->size, 1e8));
        size_t k;
        for (k = 0; k < most; k++) {
            pbwm3__probe probe;
            size_t cell;
            pbwm3__along(w, i, length * ((double)k + 0.5) / (double)most, probe.p);
            cell = pbwm3__field_cell(w, probe.p);
            probe.chain = i;
            probe.next = head[cell];
            head[cell] = (pbw_index)probes->count;
            if (probes->count >= PBW_NONE || !PBW_PUSH(&w->memory, *probes, probe)) {
                return 0;
            }
        }
    }
    return 1;
}

/* Returns whether two chains are one, or have an end in common. */
static int pbwm3__chains_meet(const pbwm3__work *w, size_t a, size_t b)
{
    const pbwm3__chain *x = w->chains.at + a, *y = w->chains.at + b;
    const pbwm3__chain_vertex *path = w->path.at;
    const pbw_index p = path[x->first].vertex, q = path[x->first + x->count - 1].vertex;
    const pbw_index r = path[y->first].vertex, s = path[y->first + y->count - 1].vertex;
    return a == b || p == r || p == s || q == r || q == s;
}

/* Lowers the field at probes of chains that are near each other. */
static int pbwm3__measure_chains(pbwm3__work *w)
{
    const size_t total = w->n[0] * w->n[1] * w->n[2];
    pbwsf__indices heads = { NULL, 0, 0 };
    pbwm3__probes probes = { NULL, 0, 0 };
    size_t i;
    int good, k;
    good = PBW_FIT(&w->memory, heads, total);
    if (good) {
        memset(heads.at, 0xff, heads.capacity * sizeof *heads.at);
        good = pbwm3__probe_chains(w, &probes, heads.at);
    }
    for (i = 0; good && i < probes.count && !pbwm3__ends_at(w, i, 256); i++) {
        const pbwm3__probe *probe = probes.at + i;
        double least = HUGE_VAL;
        for (k = 0; k < 27; k++) {
            const double q[3] = { probe->p[0] + (k % 3 - 1) * w->size, probe->p[1] + (k / 3 % 3 - 1) * w->size,
                                  probe->p[2] + (k / 9 - 1) * w->size };
            pbw_index other = heads.at[pbwm3__field_cell(w, q)];
            for (; other != PBW_NONE; other = probes.at[other].next) {
                const pbwm3__probe *o = probes.at + other;
                const double d = pbwsf__distance(probe->p, o->p);
                least = d < least && !pbwm3__chains_meet(w, probe->chain, o->chain) ? d : least;
            }
        }
        pbwm3__lower(w, probe->p, least / 1.5);
    }
    PBW_RELEASE(&w->memory, heads);
    PBW_RELEASE(&w->memory, probes);
    return good;
}

/* The caller's sizes at the middles of cells and of their eight parts. */
static void pbwm3__take_sizes(pbwm3__work *w)
{
    const int given = w->how.size_at != NULL || w->how.region_sizes != NULL;
    size_t i, cell = 0;
    int k;
    for (i = 0; given && i < 9 * w->n[0] * w->n[1] * w->n[2] && !pbwm3__ends_at(w, i, 1024); i++) {
        const int part = (int)(i % 9);
        double p[3], *field;
        cell = i / 9;
        for (k = 0; k < 3; k++) {
            const size_t at = k == 0 ? cell % w->n[0] : k == 1 ? cell / w->n[0] % w->n[1] : cell / w->n[0] / w->n[1];
            p[k] = w->low[k] + w->size * ((double)at + (part == 8 ? 0.5 : part >> k & 1 ? 0.75 : 0.25));
        }
        if (w->how.size_at != NULL) {
            pbwm3__lower(w, p, w->how.size_at(w->how.size_user, p));
        }
        field = w->field.at + pbwm3__field_cell(w, p);
        *field = fmin(*field, pbwm3__region_size(w, p));
    }
}

typedef struct pbwm3__lengths { const pbwm3__work *w; double *at; } pbwm3__lengths;

static pbw_status pbwm3__length_range(void *arg, size_t from, size_t to)
{
    const pbwm3__lengths *lengths = (const pbwm3__lengths *)arg;
    for (; from < to; from++) {
        double n[3];
        pbwsf__normal_of(&lengths->w->surface, (pbw_index)from, n);
        lengths->at[from] = sqrt(pbwsf__dot(n, n));
    }
    return PBW_OK;
}

/* The lengths of the triangles' normals: twice their areas. */
static pbw_status pbwm3__measure_normals(pbwm3__work *w, pbwsf__numbers *normal)
{
    const size_t count = w->surface.triangle_count;
    pbwm3__lengths lengths = { w, NULL };
    if (!PBW_FIT(&w->memory, *normal, count)) {
        return PBW_ERROR_MEMORY;
    }
    lengths.at = normal->at;
    return pbw_for(pbwm3__inner_options(w), count, 2048, pbwm3__length_range, &lengths);
}

typedef struct pbwm3__gap {                /* a place on a triangle, and the size there */
    double p[3], size;
    uint64_t number;                       /* of its random numbers, or of the place */
    pbw_index triangle;
} pbwm3__gap;

typedef struct pbwm3__gaps {
    pbwm3__work *w;
    PBW_ARRAY(pbwm3__gap) gap;             /* a batch */
    pbwsf__numbers normal;                 /* lengths, per triangle */
    pbwsf__counts first;                   /* per triangle: the number of its first place that covers cells, from 1 */
    pbwsf__counts least;                   /* per cell of the field: 0, a ray began there; else the least place */
    int once;                              /* in each cell that has none, and only thin walls count */
} pbwm3__gaps;

/* Places on a triangle by two numbers, of which the fractions count. */
static void pbwm3__gap_place(const pbw_surface *s, pbw_index triangle, double u, double v, double p[3])
{
    double q[3];
    pbwsf__between(pbwsf__corner(s, triangle, 0), pbwsf__corner(s, triangle, 1), u - floor(u), q);
    pbwsf__between(pbwsf__corner(s, triangle, 2), q, sqrt(v - floor(v)), p);
}

/* Place k of a triangle of those that cover cells. */
static void pbwm3__cover_place(const pbw_surface *s, size_t triangle, double k, double p[3])
{
    pbwm3__gap_place(s, (pbw_index)triangle, 0.5 + 0.7548776662466927 * k, 0.5 + 0.5698402909980532 * k, p);
}

/* Returns the triangle of a place. */
static size_t pbwm3__triangle_of_place(const pbwm3__gaps *gaps, size_t number)
{
    size_t low = 0, high = gaps->w->surface.triangle_count;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        *(gaps->first.at[middle] <= number ? &low : &high) = middle;
    }
    return low;
}

static pbw_status pbwm3__gap_range(void *arg, size_t from, size_t to)
{
    const pbwm3__gaps *gaps = (const pbwm3__gaps *)arg;
    const pbw_surface *s = &gaps->w->surface;
    for (; from < to; from++) {
        pbwm3__gap *g = gaps->gap.at + from;
        if (gaps->once) {
            const size_t number = (size_t)g->number, t = pbwm3__triangle_of_place(gaps, number);
            g->triangle = (pbw_index)t;
            pbwm3__cover_place(s, t, (double)(number - gaps->first.at[t]), g->p);
        } else {
            pbwm3__gap_place(s, g->triangle, pbwm3__random(g->number), pbwm3__random(g->number + 1), g->p);
        }
        g->size = pbwm3__measure_gap(gaps->w, g->triangle, g->p);
    }
    return PBW_OK;
}

/* Threads measure the gaps of the batch; the field takes them in order. */
static pbw_status pbwm3__lower_gaps(pbwm3__gaps *gaps)
{
    pbwm3__work *w = gaps->w;
    const pbw_status status = pbw_for(pbwm3__inner_options(w), gaps->gap.count, 64, pbwm3__gap_range, gaps);
    size_t i;
    for (i = 0; status == PBW_OK && i < gaps->gap.count; i++) {
        const double size = gaps->gap.at[i].size;
        const size_t cell = pbwm3__field_cell(w, gaps->gap.at[i].p);
        double *field = w->field.at + cell;
        *field = !gaps->once || size < 0.5 * w->size ? fmin(*field, size) : *field;
        gaps->least.at[cell] = 0;
    }
    gaps->gap.count = 0;
    return status;
}

static pbw_status pbwm3__add_gap(pbwm3__gaps *gaps, size_t triangle, uint64_t number)
{
    pbwm3__gap *gap = gaps->gap.at + gaps->gap.count;
    gap->triangle = (pbw_index)triangle;
    gap->number = number;
    return ++gaps->gap.count == PBWM3__BATCH ? pbwm3__lower_gaps(gaps) : PBW_OK;
}

/* Finds the least place of a range in each cell without a ray. */
static pbw_status pbwm3__cover_range(void *arg, size_t from, size_t to)
{
    const pbwm3__gaps *gaps = (const pbwm3__gaps *)arg;
    const size_t *first = gaps->first.at;
    size_t i, t = pbwm3__triangle_of_place(gaps, from + 1);
    for (i = from + 1; i <= to; i++) {
        double p[3];
        size_t *least, old;
        t += i == first[t + 1];
        pbwm3__cover_place(&gaps->w->surface, t, (double)(i - first[t]), p);
        least = gaps->least.at + pbwm3__field_cell(gaps->w, p);
        old = PBW_ATOMIC_LOAD(least);
        while (i < old && !PBW_ATOMIC_CAS(least, &old, i)) {
        }
    }
    return PBW_OK;
}

/* Rays begin in cells that have none. */
static pbw_status pbwm3__cover_cells(pbwm3__gaps *gaps)
{
    pbwm3__work *w = gaps->w;
    const size_t count = w->surface.triangle_count;
    pbw_status status;
    size_t i, sum = 1;
    gaps->once = 1;
    for (i = 0; i < count; i++) {
        gaps->first.at[i] = sum;
        sum += (size_t)fmin(8 * gaps->normal.at[i] / (w->size * w->size) + 1, 1e9);
    }
    gaps->first.at[count] = sum;
    status = pbw_for(pbwm3__inner_options(w), sum - 1, 4096, pbwm3__cover_range, gaps);
    for (i = 0; i < gaps->least.count && status == PBW_OK; i++) {
        if (gaps->least.at[i] > 0 && gaps->least.at[i] < sum) {
            status = pbwm3__add_gap(gaps, 0, gaps->least.at[i]);
        }
    }
    return status != PBW_OK ? status : pbwm3__lower_gaps(gaps);
}

/* Rays from 4 random points for each square of the size, 16 where regions have sizes.  Of many cells they miss a few,
   and one without a size that a thin wall demands is a hole between small edges.  So one ray more begins in each cell
   that has none, among 16 points for each square of the size, at least one a triangle, along the sequence of Roberts
   (2018, "The unreasonable effectiveness of quasirandom sequences"). */
static pbw_status pbwm3__measure_gaps(pbwm3__work *w)
{
    const double dense = w->how.region_sizes != NULL ? 8 : 2;
    const size_t cells = w->n[0] * w->n[1] * w->n[2];
    uint64_t number = 1ull << 40;
    pbwm3__gaps gaps;
    pbw_status status;
    size_t i;
    memset(&gaps, 0, sizeof gaps);
    gaps.w = w;
    status = pbwm3__measure_normals(w, &gaps.normal);
    if (status == PBW_OK && PBW_FIT(&w->memory, gaps.gap, PBWM3__BATCH) && PBW_FIT(&w->memory, gaps.least, cells)
        && PBW_FIT(&w->memory, gaps.first, w->surface.triangle_count + 1)) {
        gaps.least.count = cells;
        memset(gaps.least.at, 0xff, cells * sizeof *gaps.least.at);
        for (i = 0; i < w->surface.triangle_count && status == PBW_OK; i++) {
            double wanted = dense * gaps.normal.at[i] / (w->size * w->size) + pbwm3__random(number++);
            for (; wanted >= 1 && status == PBW_OK; wanted--, number += 2) {
                status = pbwm3__add_gap(&gaps, i, number);
            }
        }
        status = status != PBW_OK ? status : pbwm3__lower_gaps(&gaps);
        status = status != PBW_OK ? status : pbwm3__cover_cells(&gaps);
    } else {
        status = status != PBW_OK ? status : PBW_ERROR_MEMORY;
    }
    PBW_RELEASE(&w->memory, gaps.normal);
    PBW_RELEASE(&w->memory, gaps.gap);
    PBW_RELEASE(&w->memory, gaps.least);
    PBW_RELEASE(&w->memory, gaps.first);
    return status;
}

enum { PBWM3__AREAS = 256 };               /* triangles of a slice */

typedef struct pbwm3__area { double plain, squares; } pbwm3__area;     /* of a slice; in squares of local sizes */

typedef struct pbwm3__areas { const pbwm3__work *w; pbwm3__area *slice; } pbwm3__areas;

static pbw_status pbwm3__area_range(void *arg, size_t from, size_t to)
{
    const pbwm3__areas *areas = (const pbwm3__areas *)arg;
    pbwm3__area sum = { 0, 0 };
    const size_t slice = from / PBWM3__AREAS;
    size_t spread = 0;
    for (; from < to; from++) {
        double n[3];
        pbwsf__normal_of(&areas->w->surface, (pbw_index)from, n);
        sum.plain += sqrt(pbwsf__dot(n, n)) / 2;
        sum.squares += pbwm3__spread_area(areas->w, (pbw_index)from, NULL, &spread);
    }
    areas->slice[slice] = sum;
    return PBW_OK;
}

/* Estimates the number of tetrahedra.  With volume V, area A and size h, a ball or a box of 10^4 to 10^6 tetrahedra
   has about 5 V / h^3 + 8 A / h^2 of them; local sizes concern the area, as they are small at walls. */
static pbw_status pbwm3__estimate(pbwm3__work *w)
{
    pbw_solid_report *r = w->report;
    const size_t count = w->surface.triangle_count;
    PBW_ARRAY(pbwm3__area) slices = { NULL, 0, 0 };
    pbwm3__areas areas = { w, NULL };
    pbw_status status = PBW_ERROR_MEMORY;
    double squares = 0, area = 0;
    size_t i;
    if (PBW_FIT(&w->memory, slices, count / PBWM3__AREAS + 1)) {
        areas.slice = slices.at;
        status = pbw_for(pbwm3__inner_options(w), count, PBWM3__AREAS, pbwm3__area_range, &areas);
    }
    for (i = 0; i * PBWM3__AREAS < count && status == PBW_OK; i++) {
        area += slices.at[i].plain;
        squares += slices.at[i].squares;
    }
    PBW_RELEASE(&w->memory, slices);
    if (status != PBW_OK) {
        return status;
    }
    w->mean = squares > 0 ? fmax(w->least, sqrt(area / squares)) : w->size;
    r->estimate = 5 * fabs(r->input_volume) / w->size / w->size / w->size + 8 * squares;
    r->refusal = r->estimate > (w->how.most > 0 ? w->how.most : 5e7) ? PBW_SOLID_LARGE : PBW_SOLID_FILLED;
    return r->refusal == PBW_SOLID_LARGE ? PBW_ERROR_TOO_LARGE : PBW_OK;
}

/* Fills the field, and estimates. */
static pbw_status pbwm3__fill_field(pbwm3__work *w)
{
    const size_t total = w->n[0] * w->n[1] * w->n[2];
    pbw_status status;
    size_t i;
    w->least = w->size;
    for (i = 0; i < total; i++) {
        w->field.at[i] = w->size;
    }
    status = pbwm3__measure_gaps(w);
    if (status != PBW_OK) {
        return status;
    }
    pbwm3__take_sizes(w);
    if (!pbwm3__measure_chains(w) || (w->how.curvature > 0 && !pbwm3__measure_curvature(w))) {
        return PBW_ERROR_MEMORY;
    }
    if (pbwm3__ends(w)) {
        return PBW_CANCELLED;
    }
    for (i = 0; i < total; i++) {
        w->least = fmin(w->least, w->field.at[i]);
    }
    if (w->least < w->size) {
        pbwm3__grade(w);
    }
    return pbwm3__estimate(w);
}

#define PBWM3__GAP_TETS 2e6                /* the least gaps are kept if they need no more tetrahedra than these */

/* With chains and patches found.  The field is filled again while gaps between shells need too many tetrahedra. */
static pbw_status pbwm3__make_field(pbwm3__work *w)
{
    const int apart = w->shells.count > 1 && !w->walls && !pbwm3__has_crossings(w) && !(w->how.least_size > 0);
    pbw_status status;
    size_t total = 1;
    int k;
    w->least = w->size;
    for (k = 0; k < 3; k++) {
        w->n[k] = (size_t)ceil((w->high[k] - w->low[k]) / w->size) + 1;
        total *= w->n[k];
    }
    if (total > 50000000) {
        return pbwm3__estimate(w);                   /* too fine a grid: one size */
    }
    if (!PBW_FIT(&w->memory, w->field, total)) {
        return PBW_ERROR_MEMORY;
    }
    w->gap_floor = apart ? fmin(w->floor, w->size / 40) : w->floor;
    status = pbwm3__fill_field(w);
    while ((status == PBW_OK || w->report->refusal == PBW_SOLID_LARGE) && w->gap_floor < w->floor
           && w->report->estimate > PBWM3__GAP_TETS) {
        w->gap_floor = fmin(w->floor, 2 * w->gap_floor);
        status = pbwm3__fill_field(w);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>samples      The first points: on sharp edges, on smooth parts of the surface, inside.
   In: chains, patches, sizes.  Out: points `x` with their kinds and sets, and the pieces of chains between them.
   Holds: no two samples of smooth parts are closer than 0.65 sizes; points inside are those of a body-centred cubic
   lattice, 0.55 sizes from the surface.
   ------------------------------------------------------------------------------------------------------ */
/* ---- sharp edges ---- */

/* How many local sizes long the chain is; a step of the sum is a quarter of the size there. */
static double pbwm3__sizes_along(const pbwm3__work *w, size_t number, double length)
{
    double sum = 0, at = 0, p[3];
    if (!(w->least < w->size)) {
        return length / w->size;
    }
    while (at < length) {
        double step;
        pbwm3__along(w, number, at, p);
        step = fmin(0.25 * pbwm3__size(w, p), length - at);
        sum += step / pbwm3__size(w, p);
        at = at + step > at ? at + step : length;
    }
    return sum;
}

/* Returns where on the chain so many local sizes after `from` are. */
static double pbwm3__step_along(const pbwm3__work *w, size_t number, double from, double sizes)
{
    double p[3];
    if (!(w->least < w->size)) {
        return from + sizes * w->size;
    }
    while (sizes > 0) {
        const double part = fmin(0.25, sizes);
        pbwm3__along(w, number, from, p);
        from += part * pbwm3__size(w, p);
        sizes -= part;
    }
    return from;
}

/* Returns whether a chain is noise of a scan: it is short and ends on a smooth part. */
static int pbwm3__is_noise(const pbwm3__work *w, const pbwm3__chain *chain)
{
    return chain->loose
        && w->path.at[chain->first + chain->count - 1].along < 2 * w->size;
}

/* Samples a chain evenly; corner: the numbers of points at vertices, PBW_NONE where there is none yet. */
static int pbwm3__sample_chain(pbwm3__work *w, const pbwm3__stars *stars, size_t number, pbw_index *corner)
{
    pbwm3__chain *chain = w->chains.at + number;
    const pbwm3__chain_vertex *path = w->path.at + chain->first;
    const pbw_index ends[2] = { path[0].vertex, path[chain->count - 1].vertex };
    const double length = path[chain->count - 1].along, sum = pbwm3__sizes_along(w, number, length);
    const double wanted = ceil(sum / 0.6);
    const int closed = chain->closed;
    size_t count, i;
    pbwm3__piece piece;
    if (!(wanted < 1e9)) {
        return 0;
    }
    if (pbwm3__is_noise(w, chain)) {
        return 1;
    }
    count = wanted < (closed ? 3 : 1) ? (closed ? 3 : 1) : (size_t)wanted;
    chain->set = pbwm3__set_at(w, stars, path[0].vertex, path[1].vertex);
    for (i = 0; i < 2; i++) {
        if (corner[ends[i]] == PBW_NONE) {
            const size_t set = pbwm3__set_at(w, stars, ends[i], ends[i]);
            corner[ends[i]] = set == (size_t)-1 ? PBW_NONE
                            : pbwm3__add(w, w->surface.points + 3 * (size_t)ends[i], PBWM3__SHARP, set);
        }
        if (chain->set == (size_t)-1 || corner[ends[i]] == PBW_NONE) {
            return 0;
        }
    }
    piece.a = corner[ends[0]];
    piece.from = 0;
    piece.chain = number;
    for (i = 1; i <= count; i++) {
        double p[3];
        piece.to = i < count ? pbwm3__step_along(w, number, piece.from, sum / (double)count) : length;
        pbwm3__along(w, number, piece.to, p);
        piece.b = i < count ? pbwm3__add(w, p, PBWM3__SHARP, chain->set) : corner[ends[1]];
        if (piece.b == PBW_NONE || !PBW_PUSH(&w->memory, w->pieces, piece)) {
            return 0;
        }
        piece.a = piece.b;
        piece.from = piece.to;
    }
    return 1;
}

static pbw_status pbwm3__sample_sharp(pbwm3__work *w)
{
    pbwsf__indices corner = { NULL, 0, 0 };
    pbwm3__stars stars;
    size_t i;
    int good;
    memset(&stars, 0, sizeof stars);
    if (w->chains.count == 0) {
        return PBW_OK;
    }
    good = pbwm3__make_stars(w, &stars)
        && PBW_FIT(&w->memory, corner, w->surface.point_count + 1);
    if (good) {
        memset(corner.at, 0xff, corner.capacity * sizeof *corner.at);
    }
    for (i = 0; good && i < w->chains.count && !pbwm3__ends_at(w, i, 16); i++) {
        good = pbwm3__sample_chain(w, &stars, i, corner.at);
    }
    PBW_RELEASE(&w->memory, corner);
    pbwm3__free_stars(w, &stars);
    return !good ? PBW_ERROR_MEMORY : pbwm3__ends(w) ? PBW_CANCELLED : PBW_OK;
}

/* ---- smooth parts, by darts ---- */

typedef struct pbwm3__dart { double p[3], size; pbw_index patch; int stays; } pbwm3__dart;

typedef struct pbwm3__throw {              /* a batch of darts: numbers first, first + 1, ... */
    pbwm3__work *w;
    const double *area;                    /* sums over triangles */
    uint64_t first;
    pbwm3__dart *dart;
} pbwm3__throw;

/* Throws dart i at the surface; stays: no sample of earlier batches is near.  Local sizes reject darts so that each
   square of the local size gets the same number. */
static void pbwm3__throw_dart(const pbwm3__throw *b, uint64_t i, pbwm3__dart *dart)
{
    const pbwm3__work *w = b->w;
    const size_t triangles = w->surface.triangle_count;
    const double at = pbwm3__random(3 * i) * b->area[triangles - 1];
    double u = pbwm3__random(3 * i + 1), v = pbwm3__random(3 * i + 2), size;
    size_t low = 0, high = triangles - 1;
    int k;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        *(b->area[middle] > at ? &high : &low) = b->area[middle] > at ? middle : middle + 1;
    }
    u = u + v > 1 ? 1 - u : u;
    v = u + v > 1 ? 1 - v : v;
    for (k = 0; k < 3; k++) {
        const double a = pbwsf__corner(&w->surface, (pbw_index)low, 0)[k];
        dart->p[k] = a + u * (pbwsf__corner(&w->surface, (pbw_index)low, 1)[k] - a)
                   + v * (pbwsf__corner(&w->surface, (pbw_index)low, 2)[k] - a);
    }
    size = pbwm3__size(w, dart->p);
    dart->stays = !(size > w->least && pbwm3__random(~i) * size * size > w->least * w->least);
    if (dart->stays && w->input->value != NULL) {
        double from[3];
        memcpy(from, dart->p, sizeof from);
        pbwm3__to_zero(w, dart->p);                  /* the surface is at most that far: most darts end here */
        dart->stays = !(pbwsf__distance(from, dart->p) < 0.9 * w->size
                        && pbwm3__has_near(w, dart->p, 0.65 * size, PBWM3__SHARP, PBWM3__SMOOTH));
    }
    if (dart->stays) {
        dart->patch = w->input->value != NULL ? (pbw_index)pbwm3__to_patch(w, dart->p) : w->patch.at[low];
        dart->size = size;
        dart->stays = !pbwm3__has_near(w, dart->p, 0.65 * size, PBWM3__SHARP, PBWM3__SMOOTH);
    }
}

static pbw_status pbwm3__throw_range(void *arg, size_t from, size_t to)
{
    const pbwm3__throw *b = (const pbwm3__throw *)arg;
    size_t i;
    for (i = from; i < to; i++) {
        pbwm3__throw_dart(b, b->first + i, b->dart + i);
    }
    return PBW_OK;
}

/* Threads throw a batch; those darts that stay are taken in order, unless one of the same batch is near. */
static pbw_status pbwm3__throw_batch(pbwm3__throw *b, size_t count)
{
    pbwm3__work *w = b->w;
    const pbw_status status = pbw_for(pbwm3__inner_options(w), count, 128, pbwm3__throw_range, b);
    size_t i;
    for (i = 0; status == PBW_OK && i < count; i++) {
        const pbwm3__dart *dart = b->dart + i;
        if (dart->stays && pbwm3__nearest(w, dart->p, 0.65 * dart->size, PBWM3__SHARP, PBWM3__SMOOTH) == PBW_NONE
            && pbwm3__add(w, dart->p, PBWM3__SMOOTH, dart->patch) == PBW_NONE) {
            return PBW_ERROR_MEMORY;
        }
    }
    return status;
}

static pbw_status pbwm3__throw_darts(pbwm3__work *w, const double *area)
{
    const double finest = 0.65 * w->least;
    const double wanted = 12 * area[w->surface.triangle_count - 1] / (finest * finest) + 100;
    PBW_ARRAY(pbwm3__dart) darts = { NULL, 0, 0 };
    pbwm3__throw batch;
    pbw_status status = PBW_ERROR_MEMORY;
    if (!(wanted < 4e9)) {
        return PBW_ERROR_TOO_LARGE;
    }
    batch.w = w;
    batch.area = area;
    if (PBW_FIT(&w->memory, darts, PBWM3__BATCH)) {
        batch.dart = darts.at;
        for (batch.first = 0, status = PBW_OK; status == PBW_OK && batch.first < (uint64_t)wanted;
             batch.first += PBWM3__BATCH) {
            const uint64_t left = (uint64_t)wanted - batch.first, most = PBWM3__BATCH;
            status = pbwm3__check_budget(w, 0.5 * (double)batch.first / wanted);
            status = status != PBW_OK ? status : pbwm3__throw_batch(&batch, (size_t)(left < most ? left : most));
        }
    }
    PBW_RELEASE(&w->memory, darts);
    return status;
}

static pbw_status pbwm3__sample_smooth(pbwm3__work *w)
{
    pbwsf__numbers areas = { NULL, 0, 0 };
    pbw_status status = pbwm3__measure_normals(w, &areas);
    double sum = 0;
    size_t i;
    if (status == PBW_OK) {
        for (i = 0; i < w->surface.triangle_count; i++) {
            sum += 0.5 * areas.at[i];
            areas.at[i] = sum;
        }
        status = sum > 0 ? pbwm3__throw_darts(w, areas.at) : PBW_DEGENERATE;
    }
    PBW_RELEASE(&w->memory, areas);
    return status;
}

/* ---- the lattice inside ---- */

typedef struct pbwm3__lattice {
    const pbwm3__work *w;
    int level;                             /* cells are 2^level times finer than the size, where that is local */
    double cell;
    size_t n[3], first;                    /* half cells along the axes; the batch's first */
    unsigned char *inside;                 /* per half cell of a batch */
} pbwm3__lattice;

static void pbwm3__lattice_point(const pbwm3__lattice *l, size_t i, double p[3])
{
    p[0] = l->w->low[0] + (0.5 * (double)(i % l->n[0]) + 0.31) * l->cell;
    p[1] = l->w->low[1] + (0.5 * (double)(i / l->n[0] % l->n[1]) + 0.31) * l->cell;
    p[2] = l->w->low[2] + (0.5 * (double)(i / l->n[0] / l->n[1]) + 0.31) * l->cell;
}

/* Makes the lattice points of a range: half cells with three even or three odd numbers. */
static pbw_status pbwm3__lattice_range(void *arg, size_t from, size_t to)
{
    const pbwm3__lattice *l = (const pbwm3__lattice *)arg;
    const pbwm3__work *w = l->w;
    size_t i;
    memset(l->inside + from, 0, to - from);
    for (i = l->first + from; i < l->first + to; i++) {
        const size_t x = i % l->n[0], y = i / l->n[0] % l->n[1], z = i / l->n[0] / l->n[1];
        double p[3], size;
        if (((x ^ y) & 1) != 0 || ((y ^ z) & 1) != 0) {
            continue;
        }
        pbwm3__lattice_point(l, i, p);
        if (l->level > 1 && w->field.at[pbwm3__field_cell(w, p)] > 4 * l->cell) {
            const double along = (p[0] - w->low[0]) / w->size, left = (floor(along) + 1 - along) * w->size;
            i += (size_t)fmin(2 * left / l->cell, (double)(l->n[0] - 1 - x));    /* coarse up to this cell's end */
            continue;
        }
        size = pbwm3__size(w, p);
        l->inside[i - l->first] = l->level == (int)floor(log2(w->size / size) + 0.5) && pbwm3__inside(w, p)
                               && !pbwsf__is_near(&w->surface, p, 0.55 * size);
    }
    return PBW_OK;
}

static pbw_status pbwm3__take_lattice(pbwm3__work *w, const pbwm3__lattice *l, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++) {
        double p[3];
        if (!l->inside[i]) {
            continue;
        }
        pbwm3__lattice_point(l, l->first + i, p);
        if ((l->level == 0 || pbwm3__nearest(w, p, 0.7 * pbwm3__size(w, p), PBWM3__INSIDE, PBWM3__INSIDE) == PBW_NONE)
            && pbwm3__add(w, p, PBWM3__INSIDE, 0) == PBW_NONE) {
            return PBW_ERROR_MEMORY;
        }
    }
    return PBW_OK;
}

static pbw_status pbwm3__sample_level(pbwm3__work *w, int level)
{
    const size_t batch = (size_t)1 << 17;
    pbwsf__flags inside = { NULL, 0, 0 };
    pbwm3__lattice l;
    pbw_status status = PBW_OK;
    size_t k, total = 1;
    memset(&l, 0, sizeof l);
    l.w = w;
    l.level = level;
    l.cell = 1.15 * ldexp(w->size, -level);
    for (k = 0; k < 3; k++) {
        const double cells = ceil(2 * (w->high[k] - w->low[k]) / l.cell);
        if (!(cells < 1e6)) {
            return PBW_ERROR_TOO_LARGE;
        }
        l.n[k] = (size_t)cells + 1;
        total *= l.n[k];
    }
    if (total / 4 >= PBW_NONE / 8) {
        return PBW_ERROR_TOO_LARGE;
    }
    if (!PBW_FIT(&w->memory, inside, batch)) {
        return PBW_ERROR_MEMORY;
    }
    l.inside = inside.at;
    for (l.first = 0; status == PBW_OK && l.first < total; l.first += batch) {
        const size_t count = total - l.first < batch ? total - l.first : batch;
        status = pbwm3__check_budget(w, level == 0 ? 0.5 + 0.5 * (double)l.first / (double)total : 1);
        status = status != PBW_OK ? status : pbw_for(pbwm3__inner_options(w), count, 1024, pbwm3__lattice_range, &l);
        status = status != PBW_OK ? status : pbwm3__take_lattice(w, &l, count);
    }
    PBW_RELEASE(&w->memory, inside);
    return status;
}

static pbw_status pbwm3__sample_inside(pbwm3__work *w)
{
    pbw_status status = PBW_OK;
    int level;
    for (level = 0; status == PBW_OK && ldexp(w->least, level) < 1.42 * w->size; level++) {
        status = pbwm3__sample_level(w, level);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>labels       The triangulation of the points, and the label of each tetrahedron.
   In: points.  Out: `mesh`, with the circumcentre and the label of each tetrahedron.
   ------------------------------------------------------------------------------------------------------ */

/* The circumcentre, far away for flat tetrahedra; up to rounding, as it only decides what is added and labelled. */
static void pbwm3__circumcentre(const double *const c[4], double out[3])
{
    pbwim__shape s;
    int i, k;
    pbwim__shape_of(c, &s);
    memcpy(out, c[0], 3 * sizeof *out);
    for (i = 0; i < 3; i++) {
        for (k = 0; k < 3; k++) {
            out[k] += s.square[i] * s.normal[i + 1][k] / (2 * s.volume6);
        }
    }
}

/* Returns whether a tetrahedron is flat: its corners lie on one sheet of the surface, and it is outside.  Samples of
   a plane or of a straight edge are coplanar or collinear up to rounding, so tetrahedra of that thickness occur.
   Their circumcentres are noise.  If three corners are collinear, so are the dihedral angles: the volume alone
   decides.  It also decides for tetrahedra that bridge patches. */
static int pbwm3__is_flat(const pbwm3__work *w, const pbw_index c[4], int bridge)
{
    const double *p[4];
    double middle[3] = { 0, 0, 0 }, longest = 0, size;
    pbwim__shape shape;
    int i, k;
    for (i = 0; i < 4; i++) {
        p[i] = w->x.at[c[i]];
        if (w->kind.at[c[i]] == PBWM3__INSIDE) {
            return 0;
        }
        for (k = 0; k < 3; k++) {
            middle[k] += 0.25 * p[i][k];
        }
    }
    pbwim__shape_of(p, &shape);
    for (i = 0; i < 6; i++) {
        longest = fmax(longest, shape.square[i]);
    }
    if (shape.volume6 < 1e-10 * longest * sqrt(longest)) {
        return 1;
    }
    size = pbwm3__size(w, middle);
    if (bridge || pbwim__sine(p[0], p[1], p[2], p[3]) >= 0.004) {
        return 0;
    }
    for (i = 0; i < 6; i++) {
        double half[3];
        pbwsf__between(p[pbwim__edge[i][0]], p[pbwim__edge[i][1]], 0.5, half);
        if (pbwsf__distance(p[pbwim__edge[i][0]], p[pbwim__edge[i][1]]) > 2.2 * size
            || !pbwsf__is_near(&w->surface, half, 0.16 * size)) {
            return 0;
        }
    }
    return pbwsf__is_near(&w->surface, middle, 0.16 * size);
}

/* Returns whether a tetrahedron's corners are all on the surface but on no common patch: it joins two sides of a
   sharp edge or of a thin wall.  Its middle gives the label, as beneath acute edges the circumcentre is beyond the
   other side. */
static int pbwm3__bridges(const pbwm3__work *w, const pbw_index c[4])
{
    int i;
    for (i = 0; i < 4 && w->kind.at[c[i]] != PBWM3__INSIDE; i++) {
    }
    return i == 4 && pbwm3__common_patch(w, c, 4) == PBW_NONE;
}

static void pbwm3__middle(const double *const p[4], double middle[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        middle[k] = 0.25 * (p[0][k] + p[1][k] + p[2][k] + p[3][k]);
    }
}

static int pbwm3__label_of_middle(const pbwm3__work *w, const double *const p[4])
{
    double middle[3];
    pbwm3__middle(p, middle);
    return pbwm3__inside(w, middle);
}

/* Returns the label of a flat tetrahedron: that outside of the shell which it lies on.  With walls, each side of a
   patch has one label: it is the smaller of the two at the lowest patch that the corners have in common. */
static int pbwm3__label_outside(const pbwm3__work *w, const double *const p[4], const pbw_index c[4])
{
    double middle[3], place[3];
    pbw_index t;
    size_t around;
    if (!w->nested && !w->walls) {
        return 0;
    }
    pbwm3__middle(p, middle);
    t = pbw_surface_closest(&w->surface, middle, HUGE_VAL, place);
    if (w->walls && t != PBW_NONE) {
        const pbw_index patch = w->whole ? PBW_NONE : pbwm3__common_patch(w, c, 4);
        const pbw_index at = patch == PBW_NONE ? t : w->firsts.at[patch];
        const int front = pbwm3__side_label(w, at, 0), back = pbwm3__side_label(w, at, 1);
        return front < back ? front : back;
    }
    around = t == PBW_NONE ? 0 : w->shells.at[w->shell.at[t]].around;
    return around < 255 ? (int)around : 255;
}

static pbw_status pbwm3__label_range(void *arg, size_t from, size_t to)
{
    pbwm3__work *w = (pbwm3__work *)arg;
    size_t t;
    int i, away, bridge;
    for (t = from; t < to; t++) {
        const pbw_index *c = w->now.mesh.simplices + 4 * t, same = w->same.at[t];
        double *centre = w->now.centre.at[t];
        const double *p[4];
        if (same != PBW_NONE) {
            memcpy(centre, w->last.centre.at[same], 3 * sizeof *centre);
            w->now.label.at[t] = w->last.label.at[same];
            continue;
        }
        for (i = 0; i < 4; i++) {
            p[i] = w->x.at[c[i]];
        }
        pbwm3__circumcentre(p, centre);
        for (i = away = 0; i < 3; i++) {
            away += !(centre[i] > w->low[i] && centre[i] < w->high[i]);
            if (!(fabs(centre[i] - w->low[i]) < 1e6 * w->size + 1e3 * (w->high[i] - w->low[i]))) {
                memcpy(centre, p[0], 3 * sizeof *centre);    /* rounding decides the direction */
                away = 1;
                break;
            }
        }
        bridge = pbwm3__bridges(w, c);
        w->now.label.at[t] = away && !bridge ? 0 : pbwm3__is_flat(w, c, bridge) ? pbwm3__label_outside(w, p, c)
                           : bridge ? pbwm3__label_of_middle(w, p) : pbwm3__inside(w, centre);
    }
    return PBW_OK;
}

/* The first place in a table of so many, a power of 2, for a tetrahedron with these corners. */
static size_t pbwm3__hash_corners(const pbw_index c[4], size_t places)
{
    const uint64_t low = (uint64_t)c[0] << 32 | c[1], high = (uint64_t)c[2] << 32 | c[3];
    const uint64_t key = (low ^ high * 0x9e3779b97f4a7c15u) * 0xbf58476d1ce4e5b9u;
    return (size_t)(key ^ key >> 31) & (places - 1);
}

typedef struct pbwm3__matching {
    pbwm3__work *w;
    pbw_index *table;                      /* tetrahedra of the last triangulation, by their corners */
    size_t places;
} pbwm3__matching;

static pbw_status pbwm3__clear_range(void *arg, size_t from, size_t to)
{
    memset(((pbwm3__matching *)arg)->table + from, 0xff, (to - from) * sizeof(pbw_index));
    return PBW_OK;
}

static pbw_status pbwm3__enter_range(void *arg, size_t from, size_t to)
{
    const pbwm3__matching *match = (const pbwm3__matching *)arg;
    const pbw_index *corners = match->w->last.mesh.simplices;
    for (; from < to; from++) {
        size_t at = pbwm3__hash_corners(corners + 4 * from, match->places);
        pbw_index old = PBW_NONE;
        while (!PBW_ATOMIC_CAS(&match->table[at], &old, (pbw_index)from)) {
            at = old == PBW_NONE ? at : (at + 1) & (match->places - 1);      /* else it failed for no reason */
            old = PBW_NONE;
        }
    }
    return PBW_OK;
}

static pbw_status pbwm3__match_range(void *arg, size_t from, size_t to)
{
    const pbwm3__matching *match = (const pbwm3__matching *)arg;
    const pbwm3__work *w = match->w;
    const pbw_index *last = w->last.mesh.simplices;
    for (; from < to; from++) {
        const pbw_index *c = w->now.mesh.simplices + 4 * from;
        size_t at;
        int i;
        w->same.at[from] = PBW_NONE;
        for (i = 0; i < 4 && !w->moved.at[c[i]]; i++) {
        }
        if (i < 4 || match->table == NULL) {
            continue;
        }
        for (at = pbwm3__hash_corners(c, match->places); match->table[at] != PBW_NONE
             && memcmp(last + 4 * (size_t)match->table[at], c, 4 * sizeof *c) != 0;
             at = (at + 1) & (match->places - 1)) {
        }
        w->same.at[from] = match->table[at];
    }
    return PBW_OK;
}

/* Finds the tetrahedra of the last triangulation of which no corner has moved, in a hash table.  Their centres,
   labels and needs are what they were.  Returns 0 without memory. */
static int pbwm3__find_same(pbwm3__work *w)
{
    const size_t tells = w->last.mesh.simplex_count, count = w->now.mesh.simplex_count;
    pbwsf__indices table = { NULL, 0, 0 };
    pbwm3__matching match = { w, NULL, 16 };
    int good = PBW_FIT(&w->memory, w->same, count + 1);
    while (match.places < 2 * tells) {
        match.places *= 2;
    }
    if (good && tells > 0) {
        good = PBW_FIT(&w->memory, table, match.places);
        match.table = table.at;
        good = good && pbwm3__for(w, match.places, 4 * PBWM3__SLICE, pbwm3__clear_range, &match)
            && pbwm3__for(w, tells, PBWM3__SLICE, pbwm3__enter_range, &match);
    }
    good = good && pbwm3__for(w, count, PBWM3__SLICE, pbwm3__match_range, &match);
    PBW_RELEASE(&w->memory, table);
    return good;
}

static pbw_status pbwm3__rebuild(pbwm3__work *w)
{
    pbwm3__triangulation before = w->last;
    pbw_options options;
    pbw_status status;
    size_t room;
    pbwm3__drop_mesh(w, &before.mesh);
    w->last = w->now;
    w->now = before;
    options = *pbwm3__inner_options(w);
    options.flags = PBW_BORROW;
    status = pbw_triangulate(3, w->x.at[0], NULL, w->x.count, &options, &w->now.mesh);
    w->memory.used += pbwm3__mesh_bytes(&w->now.mesh);
    if (status != PBW_OK) {
        return status;
    }
    room = w->now.mesh.simplex_count;
    if (w->now.label.capacity < room) {
        room += room / 8 + 1;
        if (!PBW_FIT(&w->memory, w->now.label, room) || !PBW_FIT(&w->memory, w->now.centre, room)) {
            return PBW_ERROR_MEMORY;
        }
    }
    if (!pbwm3__find_same(w)) {
        return PBW_ERROR_MEMORY;
    }
    memset(w->moved.at, 0, w->moved.count);
    return pbw_for(pbwm3__inner_options(w), w->now.mesh.simplex_count, 256, pbwm3__label_range, w);
}

static int pbwm3__label_of(const pbwm3__work *w, pbw_index t)
{
    return t != PBW_NONE ? w->now.label.at[t] : 0;
}

/* ------------------------------------------------------------------------------------------------------
   >>manifold     Where the boundary is no manifold.
   In: facets, with the labels of what they bound.  Out: edges without exactly two facets, points with several fans of
   facets, the Euler number.
   ------------------------------------------------------------------------------------------------------ */

typedef struct pbwm3__topology {
    pbwsf__pairs edges;                    /* bad edges */
    pbwsf__flags flags;                    /* per point: 1 it has several fans */
    size_t bad_edges, bad_points;
    long euler;
} pbwm3__topology;

/* Lists the edges that have not exactly two facets, and joins the corners of facets across the others.  The edges are
   sorted.  Returns 0 without memory, or if the work must end. */
static int pbwm3__join_fans(pbwm3__work *w, const pbwim__facet *edge, size_t count, size_t *parent,
                            pbwm3__topology *top)
{
    size_t i, k, done = 0;
    for (i = 0; i < count && !pbwm3__ends_at(w, done, 65536); i = k, done++) {
        const size_t a = 3 * (size_t)edge[i].t, b = i + 1 < count ? 3 * (size_t)edge[i + 1].t : 0;
        for (k = i + 1; k < count && memcmp(edge[i].v, edge[k].v, 2 * sizeof(pbw_index)) == 0; k++) {
        }
        top->euler--;
        if (k - i == 2) {                            /* corners at v[0]: where the edge starts if it goes upwards */
            const size_t first = (size_t)edge[i].i, second = (size_t)edge[i + 1].i;
            const size_t low = edge[i].v[2] ? first : (first + 1) % 3;
            const size_t low2 = edge[i + 1].v[2] ? second : (second + 1) % 3;
            const size_t other = edge[i].v[2] ? (first + 1) % 3 : first;
            const size_t other2 = edge[i + 1].v[2] ? (second + 1) % 3 : second;
            pbwm3__join(parent, a + low, b + low2);
            pbwm3__join(parent, a + other, b + other2);
        } else {
            if (!PBW_RESERVE(&w->memory, top->edges, 1)) {
                return 0;
            }
            memcpy(top->edges.at[top->edges.count++], edge[i].v, sizeof *top->edges.at);
            top->bad_edges++;
        }
    }
    return !pbwm3__has_ended(w);
}

/* Examines a closed set of facets.  Returns 0 without memory, or if the work must end. */
static int pbwm3__examine(pbwm3__work *w, const pbw_index *facets, size_t count, size_t points,
                          pbwm3__topology *top)
{
    pbw_memory *memory = &w->memory;
    pbwim__sorting sorting;
    pbwsf__counts parents = { NULL, 0, 0 };
    const pbwim__facet *edge = pbwm3__edges(w, facets, count, points, &sorting);
    unsigned char *flag;
    size_t i;
    int good;
    memset(top, 0, sizeof *top);
    good = edge != NULL && pbwm3__start_trees(memory, &parents, 3 * count)
        && PBW_ZEROS(memory, top->flags, points + 1)
        && pbwm3__join_fans(w, edge, 3 * count, parents.at, top);
    flag = top->flags.at;
    top->euler += (long)count;
    for (i = 0; good && i < 3 * count && !pbwm3__ends_at(w, i, 65536); i++) {    /* fans: 0 none, 2 one, 1 several */
        if (parents.at[i] == i) {
            top->euler += flag[facets[i]] == 0;
            top->bad_points += flag[facets[i]] == 2;
            flag[facets[i]] = flag[facets[i]] == 0 ? 2 : 1;
        }
    }
    for (i = 0; good && i < points; i++) {
        flag[i] = flag[i] == 1;
    }
    pbwim__end_sorting(memory, &sorting);
    PBW_RELEASE(memory, parents);
    return good && !pbwm3__has_ended(w);
}

/* Gives the corners of facets separate numbers for each label; owner: their points.  Returns 0 without memory. */
static int pbwm3__split_by_label(pbwm3__work *w, pbwsf__triples *facets, const pbwm3__labels *labels, size_t points,
                                 pbwsf__indices *owner)
{
    const int *label = labels->at;
    pbwsf__counts first = { NULL, 0, 0 }, order = { NULL, 0, 0 };
    pbwsf__indices own = { NULL, 0, 0 };             /* per point, its number for the label `last` */
    pbwm3__labels last = { NULL, 0, 0 };
    size_t i;
    int good = PBW_ZEROS(&w->memory, first, w->shells.count + 3) && PBW_FIT(&w->memory, order, facets->count + 1)
        && PBW_FIT(&w->memory, own, points + 1) && PBW_ZEROS(&w->memory, last, points + 1);
    for (i = 0; good && i < facets->count; i++) {
        first.at[label[i] + 1]++;
    }
    for (i = 0; good && i < w->shells.count + 2; i++) {
        first.at[i + 1] += first.at[i];
    }
    for (i = 0; good && i < facets->count; i++) {
        order.at[first.at[label[i]]++] = i;
    }
    for (i = 0; good && i < 3 * facets->count; i++) {
        const size_t facet = order.at[i / 3];
        pbw_index *corner = &facets->at[facet][i % 3];
        if (last.at[*corner] != label[facet]) {
            last.at[*corner] = label[facet];
            own.at[*corner] = (pbw_index)owner->count;
            good = PBW_PUSH(&w->memory, *owner, *corner);
        }
        *corner = own.at[*corner];
    }
    PBW_RELEASE(&w->memory, first);
    PBW_RELEASE(&w->memory, order);
    PBW_RELEASE(&w->memory, own);
    PBW_RELEASE(&w->memory, last);
    return good;
}

/* The Euler number of the boundaries of all regions of the input. */
static int pbwm3__measure_walls(pbwm3__work *w)
{
    pbwsf__triples facets = { NULL, 0, 0 };
    pbwm3__labels labels = { NULL, 0, 0 };
    pbwsf__indices owner = { NULL, 0, 0 };
    size_t i;
    int good = 1;
    for (i = 0; good && i < 2 * w->triangles.count; i++) {
        const int label = pbwm3__side_label(w, (pbw_index)(i / 2), (int)(i % 2));
        good = label == 0 || (PBWM3__APPEND(w, facets, w->surface.triangles + i / 2 * 3)
                              && PBW_PUSH(&w->memory, labels, label));
    }
    good = good && pbwm3__split_by_label(w, &facets, &labels, w->surface.point_count, &owner);
    w->report->input_euler = (long)owner.count - (long)facets.count / 2;     /* 3/2 edges a facet */
    PBW_RELEASE(&w->memory, facets);
    PBW_RELEASE(&w->memory, labels);
    PBW_RELEASE(&w->memory, owner);
    return good;
}

/* Examines the boundaries of all labels, each for itself: facets between two are listed for both. */
static int pbwm3__examine_labels(pbwm3__work *w, pbwsf__triples *facets, const pbwm3__labels *labels, size_t points,
                                 pbwm3__topology *top)
{
    const pbw_index *facet = (const pbw_index *)facets->at;
    pbwsf__indices owner = { NULL, 0, 0 };
    pbwsf__flags flags = { NULL, 0, 0 };
    size_t i;
    int good;
    if (!w->walls) {
        return pbwm3__examine(w, facet, facets->count, points, top);
    }
    memset(top, 0, sizeof *top);
    good = pbwm3__split_by_label(w, facets, labels, points, &owner)
        && pbwm3__examine(w, facet, facets->count, owner.count, top)
        && PBW_ZEROS(&w->memory, flags, points + 1);
    if (good) {                                      /* back to points */
        for (i = 0; i < owner.count; i++) {
            flags.at[owner.at[i]] |= top->flags.at[i];
        }
        for (i = 0; i < 3 * facets->count; i++) {
            pbw_index *corner = &facets->at[i / 3][i % 3];
            *corner = owner.at[*corner];
        }
        for (i = 0; i < 2 * top->edges.count; i++) {
            pbw_index *end = &top->edges.at[i / 2][i % 2];
            *end = owner.at[*end];
        }
        PBW_RELEASE(&w->memory, top->flags);
        top->flags = flags;
    } else {
        PBW_RELEASE(&w->memory, flags);
    }
    PBW_RELEASE(&w->memory, owner);
    return good;
}

typedef struct pbwm3__bounding {
    const pbwm3__work *w;
    pbwsf__triple *facet;
    int *label;
    int both;                              /* 1: facets between two labels are listed for both, with labels */
} pbwm3__bounding;

static size_t pbwm3__list_facets(void *lists, size_t t, size_t at)
{
    const pbwm3__bounding *b = (const pbwm3__bounding *)lists;
    const pbwm3__work *w = b->w;
    const pbw_index *c = w->now.mesh.simplices + 4 * t;
    const int label = w->now.label.at[t];
    size_t count = 0;
    int i;
    for (i = 0; i < 4 && label; i++) {
        const int other = pbwm3__label_of(w, w->now.mesh.neighbors[4 * t + (size_t)i]);
        if (b->both ? other == label : other >= label) {
            continue;
        }
        if (at != PBWM3__COUNTS) {
            pbw_index *f = b->facet[at + count];
            f[0] = c[pbwim__opposite[i][0]], f[1] = c[pbwim__opposite[i][2]], f[2] = c[pbwim__opposite[i][1]];
            if (b->both) {
                b->label[at + count] = label;
            }
        }
        count++;
    }
    return count;
}

/* Lists the boundary's facets, outward, those between two labels once; with walls, if labels is not NULL, for both
   labels, and lists the labels too. */
static int pbwm3__list_boundary(pbwm3__work *w, pbwsf__triples *facets, pbwm3__labels *labels)
{
    pbwm3__bounding b = { w, NULL, NULL, labels != NULL && w->walls };
    pbwm3__listing listing;
    size_t count = 0;
    int good = pbwm3__count_list(w, w->now.mesh.simplex_count, pbwm3__list_facets, &b, &listing, &count)
            && PBW_FIT(&w->memory, *facets, count + 1) && (!b.both || PBW_FIT(&w->memory, *labels, count + 1));
    b.facet = facets->at;
    b.label = b.both ? labels->at : NULL;
    good = pbwm3__write_list(w, &listing, good);
    facets->count = good ? count : 0;
    return good;
}

/* Finds the bad edges and points in place of those in top, and flags the ends of bad edges, too; the report gets
   their numbers. */
static pbw_status pbwm3__find_faults(pbwm3__work *w, pbwm3__topology *top)
{
    pbwsf__triples facets = { NULL, 0, 0 };
    pbwm3__labels labels = { NULL, 0, 0 };
    size_t i;
    int good;
    PBW_RELEASE(&w->memory, top->edges);
    PBW_RELEASE(&w->memory, top->flags);
    good = pbwm3__list_boundary(w, &facets, &labels)
        && pbwm3__examine_labels(w, &facets, &labels, w->x.count, top);
    for (i = 0; good && i < 2 * top->edges.count; i++) {
        top->flags.at[top->edges.at[i / 2][i % 2]] = 1;
    }
    PBW_RELEASE(&w->memory, facets);
    PBW_RELEASE(&w->memory, labels);
    w->report->bad_edges = top->bad_edges;
    w->report->bad_points = top->bad_points;
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* ------------------------------------------------------------------------------------------------------
   >>reach        Points of the surface that the boundary passes by.
   In: labelled tetrahedra.  Out: other labels for a few of them.
   At the tip of a thin horn, circumcentres are outside, and the boundary cuts the horn off beneath a point that is on
   the surface; likewise at the bottom of a narrow pit.  Tetrahedra at such a point get the labels of their middles,
   where this leaves the boundary's topology as it is.
   ------------------------------------------------------------------------------------------------------ */
/* Lists the tetrahedra at each flagged point: first[v] to first[v + 1].  Returns 0 without memory. */
static int pbwm3__list_stars(pbwm3__work *w, const unsigned char *flag, pbwsf__counts *first, pbwsf__indices *tets)
{
    const size_t count = 4 * w->now.mesh.simplex_count;
    const pbw_index *corner = w->now.mesh.simplices;
    size_t i, sum = 0;
    if (!PBW_ZEROS(&w->memory, *first, w->x.count + 2)) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        first->at[corner[i] + 2] += flag[corner[i]];
        sum += flag[corner[i]];
    }
    for (i = 0; i < w->x.count; i++) {
        first->at[i + 2] += first->at[i + 1];
    }
    if (!PBW_FIT(&w->memory, *tets, sum + 1)) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        if (flag[corner[i]]) {
            tets->at[first->at[corner[i] + 1]++] = (pbw_index)(i / 4);
        }
    }
    return 1;
}

#define PBWM3__TIP_DISTANCE 1.5            /* of options.distance: where the surface is farther, sizes are halved */

#define PBWM3__FLAT_SINE 0.34202014332566873  /* of 20 degrees */

enum { PBWM3__REACHES = 8 };               /* passes: each reaches points behind those of the one before */

typedef struct pbwm3__reaching {
    const pbwm3__work *w;
    unsigned char *bound;                  /* per point: 1, the boundary has it, or passes by near enough */
    pbw_surface boundary;
    double enough;
} pbwm3__reaching;

/* Marks the points that the boundary has. */
static pbw_status pbwm3__bound_range(void *arg, size_t from, size_t to)
{
    const pbwm3__reaching *r = (const pbwm3__reaching *)arg;
    size_t i;
    int k;
    for (i = 4 * from; i < 4 * to; i++) {
        if (pbwm3__label_of(r->w, r->w->now.mesh.neighbors[i]) != r->w->now.label.at[i / 4]) {
            for (k = 0; k < 3; k++) {
                const pbw_index v = r->w->now.mesh.simplices[i / 4 * 4 + (size_t)pbwim__opposite[i % 4][k]];
                PBW_ATOMIC_STORE(&r->bound[v], 1);
            }
        }
    }
    return PBW_OK;
}

/* Marks the points that are near the boundary. */
static pbw_status pbwm3__near_range(void *arg, size_t from, size_t to)
{
    const pbwm3__reaching *r = (const pbwm3__reaching *)arg;
    for (; from < to; from++) {
        r->bound[from] = r->bound[from] || pbwsf__is_near(&r->boundary, r->w->x.at[from], r->enough);
    }
    return PBW_OK;
}

static int pbwm3__has_corner(const pbw_index c[4], pbw_index v)
{
    return c[0] == v || c[1] == v || c[2] == v || c[3] == v;
}

/* Returns whether tetrahedron t can get label `to` without a change of topology: what it has in common with those of
   that label is a disk, of 1 to 3 of its facets.  So none of them has all corners across these facets, and there are
   no other labels.  If the disk is of 3 facets, it takes the point in its middle from the boundary, which must not be
   one of the surface.  Nor may t be flat and become a part of the mesh: its points on the surface are not moved. */
static int pbwm3__changes_simply(const pbwm3__work *w, const size_t *first, const pbw_index *tets, pbw_index t,
                                 int to)
{
    const pbw_index *corner = w->now.mesh.simplices, *neighbor = w->now.mesh.neighbors, *c = corner + 4 * (size_t)t;
    const int from = w->now.label.at[t];
    int shared[4], facets = 0, i, k;
    size_t at;
    for (i = 0; i < 4; i++) {
        shared[i] = pbwm3__label_of(w, neighbor[4 * (size_t)t + (size_t)i]) == to;
        facets += shared[i];
    }
    for (i = 0; i < 4 && facets == 3; i++) {
        facets = shared[i] || w->kind.at[c[i]] > PBWM3__SMOOTH ? facets : 0;
    }
    if (from == 0 && pbwim__sine(w->x.at[c[0]], w->x.at[c[1]], w->x.at[c[2]], w->x.at[c[3]]) < PBWM3__FLAT_SINE) {
        return 0;
    }
    for (i = 0; i < 4 && facets % 4 > 0; i++) {
        for (at = first[c[i]]; at < first[c[i] + 1]; at++) {
            const pbw_index *d = corner + 4 * (size_t)tets[at], *beside = neighbor + 4 * (size_t)tets[at];
            const int label = w->now.label.at[tets[at]];
            int meets = label == to;
            for (k = 0; k < 4; k++) {                /* beyond the hull of all points is label 0, too */
                meets = meets || (to == 0 && beside[k] == PBW_NONE && !(shared[0] && d[k] == c[0])
                                  && !(shared[1] && d[k] == c[1]) && !(shared[2] && d[k] == c[2])
                                  && !(shared[3] && d[k] == c[3]));
            }
            for (k = 0; k < 4 && meets; k++) {
                meets = !shared[k] || pbwm3__has_corner(d, c[k]);
            }
            if (meets || (label != from && label != to)) {
                return 0;
            }
        }
    }
    return facets % 4 > 0;
}

/* Gives tetrahedron t a label, which puts its corners on the boundary. */
static void pbwm3__change_label(pbwm3__work *w, unsigned char *bound, pbw_index t, int label)
{
    const pbw_index *c = w->now.mesh.simplices + 4 * (size_t)t;
    int k;
    w->now.label.at[t] = label;
    for (k = 0; k < 4; k++) {
        bound[c[k]] = 1;
    }
}

/* Returns how far the facets that t gives the boundary, if it gets label `to`, are from the surface. */
static double pbwm3__new_distance(const pbwm3__work *w, pbw_index t, int to)
{
    const pbw_index *c = w->now.mesh.simplices + 4 * (size_t)t, *neighbor = w->now.mesh.neighbors + 4 * (size_t)t;
    double most = 0, p[3], place[3];
    int i, j, k;
    for (i = 0; i < 4; i++) {
        for (j = 0; j < 4 && pbwm3__label_of(w, neighbor[i]) != to; j++) {   /* its middle, and those of its edges */
            const double *a = w->x.at[c[pbwim__opposite[i][j % 3]]], *b = w->x.at[c[pbwim__opposite[i][(j + 1) % 3]]];
            const double *d = w->x.at[c[pbwim__opposite[i][(j + 2) % 3]]];
            for (k = 0; k < 3; k++) {
                p[k] = j < 3 ? (a[k] + b[k]) / 2 : (a[k] + b[k] + d[k]) / 3;
            }
            (void)pbw_surface_closest(&w->surface, p, HUGE_VAL, place);
            most = fmax(most, pbwsf__distance(p, place));
        }
    }
    return most;
}

/* Puts point v on the boundary: tetrahedra there get the labels of their middles; if none can, the one
   with the facets nearest to the surface gets the other label, as a pit may be thinner than all of them.  Returns
   whether it changed one. */
static int pbwm3__reach_point(pbwm3__work *w, unsigned char *bound, const size_t *first, const pbw_index *tets,
                              size_t v)
{
    double least = PBWM3__TIP_DISTANCE * w->distance * w->size;
    pbw_index best = PBW_NONE;
    int changed = 1, label = 0, other, k;
    size_t at;
    while (changed) {
        for (changed = 0, at = first[v]; at < first[v + 1]; at++) {
            const pbw_index t = tets[at], *c = w->now.mesh.simplices + 4 * (size_t)t;
            const double *p[4];
            for (k = 0; k < 4; k++) {
                p[k] = w->x.at[c[k]];
            }
            other = pbwm3__label_of_middle(w, p);
            if (other != w->now.label.at[t] && pbwm3__changes_simply(w, first, tets, t, other)) {
                pbwm3__change_label(w, bound, t, other);
                changed = 1;
            }
        }
    }
    for (at = 4 * first[v]; at < 4 * first[v + 1] && !bound[v]; at++) {
        const pbw_index t = tets[at / 4];
        other = pbwm3__label_of(w, w->now.mesh.neighbors[4 * (size_t)t + at % 4]);
        if (other != w->now.label.at[t] && pbwm3__changes_simply(w, first, tets, t, other)) {
            const double distance = pbwm3__new_distance(w, t, other);
            best = distance < least ? t : best;
            label = distance < least ? other : label;
            least = fmin(least, distance);
        }
    }
    if (best != PBW_NONE) {
        pbwm3__change_label(w, bound, best, label);
    }
    return bound[v];
}

/* Marks in r->bound all points but those of the surface that are far from the boundary, and in `flag` the corners of
   the far points' tetrahedra.  *count: how many are far. */
static pbw_status pbwm3__find_far(pbwm3__work *w, pbwm3__reaching *r, unsigned char *flag, size_t *count)
{
    const pbw_index *c = w->now.mesh.simplices;
    pbwsf__triples facets = { NULL, 0, 0 };
    pbw_status status = pbw_for(pbwm3__inner_options(w), w->now.mesh.simplex_count, PBWM3__SLICE, pbwm3__bound_range,
                                r);
    size_t i, passed = 0;
    *count = 0;
    for (i = 0; i < w->x.count; i++) {
        r->bound[i] |= w->kind.at[i] > PBWM3__SMOOTH;
        passed += !r->bound[i];
    }
    if (status != PBW_OK || passed == 0) {
        return status;
    }
    status = !pbwm3__list_boundary(w, &facets, NULL) ? PBW_ERROR_MEMORY
           : pbwm3__make_surface(w, w->x.at[0], w->x.count, facets.at[0], facets.count, &r->boundary);
    status = status != PBW_OK ? status : pbw_for(pbwm3__inner_options(w), w->x.count, 256, pbwm3__near_range, r);
    for (i = 0; i < w->x.count; i++) {
        *count += !r->bound[i];
    }
    for (i = 0; i < 4 * w->now.mesh.simplex_count && *count > 0; i++) {
        if (!r->bound[c[i]]) {
            const pbw_index *all = c + i / 4 * 4;
            flag[all[0]] = flag[all[1]] = flag[all[2]] = flag[all[3]] = 1;
        }
    }
    pbwm3__drop_surface(w, &r->boundary);
    PBW_RELEASE(&w->memory, facets);
    return status;
}

/* Lets the boundary have those of the surface's points that it passes by at a distance. */
static pbw_status pbwm3__reach_points(pbwm3__work *w)
{
    pbwsf__counts first = { NULL, 0, 0 };
    pbwsf__indices tets = { NULL, 0, 0 };
    pbwsf__flags bound = { NULL, 0, 0 }, flag = { NULL, 0, 0 };
    pbwm3__reaching reaching;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, count = 0, reached = 0;
    int pass, changed = 1;
    if (pbwm3__has_crossings(w)) {                   /* parts of the surface may be inside */
        return PBW_OK;
    }
    if (PBW_ZEROS(&w->memory, bound, w->x.count + 1) && PBW_ZEROS(&w->memory, flag, w->x.count + 1)) {
        memset(&reaching, 0, sizeof reaching);
        reaching.w = w;
        reaching.bound = bound.at;
        reaching.enough = PBWM3__TIP_DISTANCE * w->distance * w->size;
        status = pbwm3__find_far(w, &reaching, flag.at, &count);
        status = status != PBW_OK || count == 0 || pbwm3__list_stars(w, flag.at, &first, &tets) ? status
               : PBW_ERROR_MEMORY;
    }
    for (pass = 0; pass < PBWM3__REACHES && status == PBW_OK && count > 0 && changed; pass++) {
        changed = 0;
        for (i = 0; i < w->x.count && !pbwm3__has_ended(w); i++) {
            if (!bound.at[i] && !pbwm3__ends_at(w, reached++, 16)) {
                changed += pbwm3__reach_point(w, bound.at, first.at, tets.at, i);
            }
        }
        status = pbwm3__has_ended(w) ? PBW_CANCELLED : PBW_OK;
    }
    PBW_RELEASE(&w->memory, first);
    PBW_RELEASE(&w->memory, tets);
    PBW_RELEASE(&w->memory, bound);
    PBW_RELEASE(&w->memory, flag);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>rounds       Points added until nothing is left to add.
   In: labelled tetrahedra.  Out: the same of more points, in rounds; the report's faults.
   ------------------------------------------------------------------------------------------------------ */
/* ---- points that facets need ---- */

static int pbwm3__is_near_surface(const pbwm3__work *w, const double p[3])
{
    return pbwsf__is_near(&w->surface, p, w->distance * pbwm3__size(w, p));
}

/* Returns whether facet i of t needs a point, and where.  A boundary facet with a corner inside needs one.  A facet
   between points without a common patch is no part of the surface, wherever its dual segment is; on the boundary it
   cuts off a sharp edge, and needs one. */
static int pbwm3__needs_point(const pbwm3__work *w, size_t t, int i, pbwm3__new_point *point)
{
    const pbw_index n = w->now.mesh.neighbors[4 * t + (size_t)i], *c = w->now.mesh.simplices + 4 * t;
    const int inner = pbwm3__label_of(w, (pbw_index)t), outer = pbwm3__label_of(w, n);
    double where = 0, *p = point->p;
    pbw_index f[3], met;
    int k, bridge;
    point->inside = PBW_NONE;
    for (k = 0; k < 3; k++) {
        f[k] = c[pbwim__opposite[i][k]];
        if (inner == outer && w->kind.at[f[k]] == PBWM3__INSIDE) {
            return 0;
        }
    }
    for (k = 0; k < 3 && w->kind.at[f[k]] != PBWM3__INSIDE; k++) {
    }
    bridge = k == 3 && pbwm3__common_patch(w, f, 3) == PBW_NONE;
    if (n != PBW_NONE && !bridge) {
        met = pbw_surface_meets(&w->surface, w->now.centre.at[t], w->now.centre.at[n], &where);
        pbwsf__between(w->now.centre.at[t], w->now.centre.at[n], where, p);
        if (met != PBW_NONE && pbwsf__distance(p, w->x.at[f[0]]) > 1.1 * pbwm3__size(w, p)) {
            return 1;
        }
    }
    for (k = 0; k < 3; k++) {
        point->inside = w->kind.at[f[k]] == PBWM3__INSIDE ? f[k] : point->inside;
        p[k] = (w->x.at[f[0]][k] + w->x.at[f[1]][k] + w->x.at[f[2]][k]) / 3;
    }
    if (inner == outer || bridge || point->inside != PBW_NONE) {
        return inner != outer;
    }
    for (i = 0; i < 3 && pbwm3__is_near_surface(w, p); i++) {        /* its middle, and those of its edges */
        pbwsf__between(w->x.at[f[i]], w->x.at[f[(i + 1) % 3]], 0.5, p);
    }
    return i < 3 || !pbwm3__is_near_surface(w, p);
}

/* Adds a point of the surface, smooth or a tip, unless others of the surface are near; it takes the place of a near
   point inside.  Returns 1 if it was added, 0 if not, -1 without memory. */
static int pbwm3__add_if_far(pbwm3__work *w, const double p[3], int kind, size_t patch, double from_sharp,
                             double from_smooth)
{
    const double size = pbwm3__size(w, p);
    pbw_index inside;
    if (pbwm3__nearest(w, p, from_sharp * size, PBWM3__SHARP, PBWM3__SHARP) != PBW_NONE
        || pbwm3__nearest(w, p, from_smooth * size, PBWM3__TIP, PBWM3__SMOOTH) != PBW_NONE) {
        return 0;
    }
    inside = pbwm3__nearest(w, p, 0.45 * size, PBWM3__INSIDE, PBWM3__INSIDE);
    if (inside != PBW_NONE) {
        pbwm3__take_from_cell(w, inside);
        memcpy(w->x.at[inside], p, 3 * sizeof *p);
        w->kind.at[inside] = (unsigned char)kind;
        w->set.at[inside] = (pbw_index)patch;
        w->moved.at[inside] = 1;
        pbwm3__put_in_cell(w, inside);
        return 1;
    }
    return pbwm3__add(w, p, kind, patch) == PBW_NONE ? -1 : 1;
}

/* Adds points at bad edges and bad points of the boundary.  Returns how many, -1 without memory. */
static long pbwm3__refine_boundary(pbwm3__work *w)
{
    pbwsf__triples facets = { NULL, 0, 0 };
    pbwm3__labels labels = { NULL, 0, 0 };
    pbwm3__topology top;
    long added = 0;
    size_t i, patch;
    int got = 0, k;
    memset(&top, 0, sizeof top);
    if (!pbwm3__list_boundary(w, &facets, &labels)
        || !pbwm3__examine_labels(w, &facets, &labels, w->x.count, &top)) {
        got = -1;
    }
    for (i = 0; got >= 0 && i < top.edges.count; i++) {
        const pbw_index *pair = top.edges.at[i];
        double p[3];
        pbwsf__between(w->x.at[pair[0]], w->x.at[pair[1]], 0.5, p);
        patch = pbwm3__to_surface(w, p);
        got = pbwm3__add_if_far(w, p, PBWM3__SMOOTH, patch, 0.08, 0.08);
        added += got;
    }
    for (i = 0; got >= 0 && top.bad_points > 0 && i < facets.count; i++) {
        const pbw_index *f = facets.at[i];
        const unsigned char *flag = top.flags.at;
        double p[3];
        if (flag[f[0]] || flag[f[1]] || flag[f[2]]) {
            for (k = 0; k < 3; k++) {
                p[k] = (w->x.at[f[0]][k] + w->x.at[f[1]][k] + w->x.at[f[2]][k]) / 3;
            }
            patch = pbwm3__to_surface(w, p);
            got = pbwm3__add_if_far(w, p, PBWM3__SMOOTH, patch, 0.08, 0.08);
            added += got;
        }
    }
    PBW_RELEASE(&w->memory, facets);
    PBW_RELEASE(&w->memory, labels);
    PBW_RELEASE(&w->memory, top.edges);
    PBW_RELEASE(&w->memory, top.flags);
    return got < 0 ? -1 : added;
}

/* ---- sharp edges: pieces that are no edges are halved, and points in their diametral balls removed ---- */

/* Removes a point that is not sharp: as a duplicate of point 0 it is no vertex of the triangulation. */
static void pbwm3__remove_point(pbwm3__work *w, pbw_index p)
{
    pbwm3__take_from_cell(w, p);
    memcpy(w->x.at[p], w->x.at[0], 3 * sizeof(double));
    w->kind.at[p] = PBWM3__REMOVED;
    w->moved.at[p] = 1;
    pbwm3__put_in_cell(w, p);
}

static int pbwm3__compare_pieces(const void *a, const void *b)
{
    const pbwm3__piece *x = (const pbwm3__piece *)a, *y = (const pbwm3__piece *)b;
    const pbw_index lx = x->a < x->b ? x->a : x->b, ly = y->a < y->b ? y->a : y->b;
    const pbw_index hx = x->a < x->b ? x->b : x->a, hy = y->a < y->b ? y->b : y->a;
    return lx != ly ? (lx > ly) - (lx < ly) : (hx > hy) - (hx < hy);
}

typedef struct pbwm3__finding { const pbwm3__work *w; unsigned char *found; } pbwm3__finding;

/* Marks in `found` the sorted pieces that are edges of tetrahedra inside. */
static pbw_status pbwm3__find_pieces(void *arg, size_t from, size_t to)
{
    const pbwm3__finding *finding = (const pbwm3__finding *)arg;
    const pbwm3__work *w = finding->w;
    const pbwm3__piece *piece = w->pieces.at, *at;
    int e;
    for (; from < to; from++) {
        const pbw_index *c = w->now.mesh.simplices + 4 * from;
        for (e = 0; e < 6 && w->now.label.at[from]; e++) {
            pbwm3__piece key;
            key.a = c[pbwim__edge[e][0]];
            key.b = c[pbwim__edge[e][1]];
            if (w->kind.at[key.a] == PBWM3__SHARP && w->kind.at[key.b] == PBWM3__SHARP) {
                at = (const pbwm3__piece *)bsearch(&key, piece, w->pieces.count, sizeof key, pbwm3__compare_pieces);
                if (at != NULL) {
                    PBW_ATOMIC_STORE(&finding->found[at - piece], 1);
                }
            }
        }
    }
    return PBW_OK;
}

static void pbwm3__clear_ball(pbwm3__work *w, const pbwm3__piece *piece)
{
    const double *a = w->x.at[piece->a], *b = w->x.at[piece->b];
    double middle[3];
    pbw_index p;
    pbwsf__between(a, b, 0.5, middle);
    do {
        p = pbwm3__nearest(w, middle, 0.5 * pbwsf__distance(a, b), PBWM3__TIP, PBWM3__INSIDE);
        if (p != PBW_NONE) {
            pbwm3__remove_point(w, p);
        }
    } while (p != PBW_NONE);
}

/* Sorts the pieces of sharp edges, flags those that are edges of tetrahedra inside, and counts the others in the
   report.  Returns 0 without memory. */
static int pbwm3__find_missing(pbwm3__work *w, pbwsf__flags *found)
{
    const size_t count = w->pieces.count;
    pbwm3__finding finding;
    size_t i;
    w->report->missing_edges = 0;
    if (!PBW_ZEROS(&w->memory, *found, count)) {
        return 0;
    }
    finding.w = w;
    finding.found = found->at;
    if (count > 0) {
        qsort(w->pieces.at, count, sizeof(pbwm3__piece), pbwm3__compare_pieces);
        if (!pbwm3__for(w, w->now.mesh.simplex_count, PBWM3__SLICE, pbwm3__find_pieces, &finding)) {
            return 0;
        }
    }
    for (i = 0; i < count; i++) {
        w->report->missing_edges += !found->at[i];
    }
    return 1;
}

/* Halves missing pieces.  Returns how many points are added, -1 without memory. */
static long pbwm3__halve_pieces(pbwm3__work *w)
{
    const size_t count = w->pieces.count;
    pbwsf__flags found = { NULL, 0, 0 };
    long added = pbwm3__find_missing(w, &found) ? 0 : -1;
    size_t i;
    for (i = 0; i < count && added >= 0; i++) {
        pbwm3__piece *piece = w->pieces.at + i, second = *piece;
        double p[3];
        if (found.at[i]) {
            continue;
        }
        pbwm3__clear_ball(w, piece);
        if (piece->to - piece->from > 0.1 * w->least) {
            second.from = (piece->from + piece->to) / 2;
            pbwm3__along(w, piece->chain, second.from, p);
            second.a = pbwm3__add(w, p, PBWM3__SHARP, w->chains.at[piece->chain].set);
            piece->to = second.from;
            piece->b = second.a;
            added = second.a == PBW_NONE || !PBW_PUSH(&w->memory, w->pieces, second) ? -1 : added + 1;
        }
    }
    PBW_RELEASE(&w->memory, found);
    return added;
}

/* Sets the bits of the facets that need a point, each at the tetrahedron with the lower number. */
static pbw_status pbwm3__need_range(void *arg, size_t from, size_t to)
{
    pbwm3__work *w = (pbwm3__work *)arg;
    unsigned char *needs = w->now.needs.at;
    size_t t;
    int k;
    for (t = from; t < to; t++) {
        needs[t] = 0;
        for (k = 0; k < 4; k++) {
            const pbw_index n = w->now.mesh.neighbors[4 * t + (size_t)k];
            const pbw_index same = w->same.at[t], next = n == PBW_NONE ? PBW_NONE : w->same.at[n];
            const int known = same != PBW_NONE && next != PBW_NONE && same < next;
            pbwm3__new_point point;
            if ((n == PBW_NONE || n > t)
                && (known ? w->last.needs.at[same] >> k & 1 : pbwm3__needs_point(w, t, k, &point))) {
                needs[t] |= (unsigned char)(1 << k);
            }
        }
    }
    return PBW_OK;
}

static pbw_status pbwm3__new_point_range(void *arg, size_t from, size_t to)
{
    pbwm3__work *w = (pbwm3__work *)arg;
    pbwm3__new_point *point = w->new_points.at;
    size_t i;
    for (i = from; i < to; i++) {
        (void)pbwm3__needs_point(w, point[i].facet / 4, (int)(point[i].facet % 4), point + i);
        point[i].patch = (pbw_index)pbwm3__to_surface(w, point[i].p);
    }
    return PBW_OK;
}

static size_t pbwm3__list_needs(void *lists, size_t t, size_t at)
{
    const pbwm3__work *w = (const pbwm3__work *)lists;
    size_t count = 0, k;
    for (k = 0; k < 4; k++) {
        if (w->now.needs.at[t] >> k & 1) {
            if (at != PBWM3__COUNTS) {
                w->new_points.at[at + count].facet = 4 * t + k;
            }
            count++;
        }
    }
    return count;
}

/* Lists the points that facets need, in the order of facets: threads find these facets, then the points. */
static pbw_status pbwm3__list_new_points(pbwm3__work *w)
{
    pbw_options options = w->options;
    pbwm3__listing listing;
    pbw_status status;
    size_t count;
    int good;
    w->new_points.count = 0;
    if (w->now.needs.capacity < w->now.mesh.simplex_count
        && !PBW_FIT(&w->memory, w->now.needs, w->now.label.capacity)) {
        return PBW_ERROR_MEMORY;
    }
    options.progress = pbwm3__part_progress;
    options.progress_user = w;
    status = pbw_for(&options, w->now.mesh.simplex_count, 256, pbwm3__need_range, w);
    if (status != PBW_OK) {
        return status;
    }
    good = pbwm3__count_list(w, w->now.mesh.simplex_count, pbwm3__list_needs, w, &listing, &count)
        && PBW_RESERVE(&w->memory, w->new_points, count);
    if (!pbwm3__write_list(w, &listing, good)) {
        return PBW_ERROR_MEMORY;
    }
    w->new_points.count = count;
    return pbw_for(pbwm3__inner_options(w), count, 64, pbwm3__new_point_range, w);
}

/* Adds the points of a round.  *added: how many. */
static pbw_status pbwm3__round(pbwm3__work *w, long *added)
{
    const pbwm3__new_point *point = w->new_points.at;
    long mended;
    size_t i;
    int got = 0;
    *added = pbwm3__halve_pieces(w);
    for (i = 0; i < w->new_points.count && *added >= 0 && got >= 0; i++) {
        if (pbwm3__ends_at(w, i, 256)) {
            return PBW_CANCELLED;
        }
        got = pbwm3__add_if_far(w, point[i].p, PBWM3__SMOOTH, point[i].patch, 0.3, 0.25);
        if (got == 0 && point[i].inside != PBW_NONE && w->kind.at[point[i].inside] == PBWM3__INSIDE) {
            pbwm3__remove_point(w, point[i].inside);
            got = 1;
        }
        *added += got;
    }
    mended = *added >= 0 && got >= 0 ? pbwm3__refine_boundary(w) : -1;
    *added += mended;
    return mended < 0 ? PBW_ERROR_MEMORY : PBW_OK;
}

/* ---- places of the surface that the boundary does not reach: tips and ridges between samples ---- */

typedef struct pbwm3__place { double p[3], distance; } pbwm3__place;
typedef PBW_ARRAY(pbwm3__place) pbwm3__place_list;

typedef struct pbwm3__places {
    const pbw_surface *boundary;
    pbwm3__place *place;
    double enough;                         /* a place nearer than this needs no exact distance */
} pbwm3__places;

/* Returns whether a triangle of a surface, if there is one, is nearer to p than a distance. */
static int pbwm3__triangle_is_near(const pbw_surface *s, pbw_index triangle, const double p[3], double distance)
{
    double place[3], d[3];
    if (triangle == PBW_NONE) {
        return 0;
    }
    pbwsf__nearest_in(pbwsf__corner(s, triangle, 0), pbwsf__corner(s, triangle, 1), pbwsf__corner(s, triangle, 2), p,
                      place);
    pbwsf__minus(place, p, d);
    return pbwsf__dot(d, d) < distance * distance;
}

static pbw_status pbwm3__place_range(void *arg, size_t from, size_t to)
{
    const pbwm3__places *places = (const pbwm3__places *)arg;
    pbw_index t = PBW_NONE;                          /* near the place before */
    size_t i;
    for (i = from; i < to; i++) {
        pbwm3__place *place = places->place + i;
        double nearby[3];
        place->distance = 0;
        if (!pbwm3__triangle_is_near(places->boundary, t, place->p, places->enough)) {
            t = pbwsf__closest(places->boundary, place->p, HUGE_VAL, places->enough, nearby);
            place->distance = t == PBW_NONE ? 0 : pbwsf__distance(place->p, nearby);
        }
    }
    return PBW_OK;
}

/* Marks the vertices that sampled chains have. */
static void pbwm3__mark_chains(const pbwm3__work *w, unsigned char *chained)
{
    const pbwm3__chain_vertex *path = w->path.at;
    size_t i, k;
    for (i = 0; i < w->chains.count; i++) {
        const pbwm3__chain *chain = w->chains.at + i;
        for (k = 0; k < chain->count && !pbwm3__is_noise(w, chain); k++) {
            chained[path[chain->first + k].vertex] = 1;
        }
    }
}

typedef struct pbwm3__placing {
    const pbwm3__work *w;
    const unsigned char *chained;
    const pbwim__facet *edge;              /* sorted */
    pbwm3__place *place;
} pbwm3__placing;

/* Items are the surface's vertices, then its edges: the first of each group of equal ones gives places. */
static size_t pbwm3__list_item_places(void *lists, size_t item, size_t at)
{
    const pbwm3__placing *l = (const pbwm3__placing *)lists;
    const pbw_surface *s = &l->w->surface;
    const size_t edges = 3 * s->triangle_count;
    const pbwim__facet *edge;
    const double *a, *b;
    size_t i, parts, n;
    if (item < s->point_count) {
        if (!l->chained[item] && at != PBWM3__COUNTS) {
            memcpy(l->place[at].p, s->points + 3 * item, sizeof l->place->p);
        }
        return !l->chained[item];
    }
    i = item - s->point_count;
    edge = l->edge + i;
    if ((i > 0 && memcmp(edge[-1].v, edge->v, 2 * sizeof(pbw_index)) == 0)
        || i + 1 == edges || memcmp(edge->v, edge[1].v, 2 * sizeof(pbw_index)) != 0
        || (i + 2 < edges && memcmp(edge->v, edge[2].v, 2 * sizeof(pbw_index)) == 0)) {
        return 0;
    }
    a = s->points + 3 * (size_t)edge->v[0];
    b = s->points + 3 * (size_t)edge->v[1];
    parts = (size_t)fmax(2, fmin(ceil(2 * pbwsf__distance(a, b) / l->w->size), 1e5));
    if (pbwm3__angle_at(l->w, edge, 2) > 179
        || (l->chained[edge->v[0]] && l->chained[edge->v[1]] && pbwm3__is_sharp(l->w, edge))) {
        return 0;
    }
    for (n = 1; n < parts && at != PBWM3__COUNTS; n++) {
        pbwsf__between(a, b, (double)n / (double)parts, l->place[at + n - 1].p);
    }
    return parts - 1;
}

/* Lists the places where the surface can be far from the boundary: its vertices on no chain, and places half a size
   apart on its edges of more than a degree. */
static int pbwm3__list_places(pbwm3__work *w, const unsigned char *chained, pbwm3__place_list *places)
{
    pbwim__sorting sorting;
    pbwm3__listing listing;
    const pbw_surface *s = &w->surface;
    pbwm3__placing l = { w, chained, NULL, NULL };
    size_t count = 0;
    int good;
    l.edge = pbwm3__edges(w, s->triangles, s->triangle_count, s->point_count, &sorting);
    good = l.edge != NULL;
    if (good) {
        good = pbwm3__count_list(w, s->point_count + 3 * s->triangle_count, pbwm3__list_item_places, &l, &listing,
                                 &count) && PBW_FIT(&w->memory, *places, count + 1);
        l.place = places->at;
        good = pbwm3__write_list(w, &listing, good);
        places->count = good ? count : 0;
    }
    pbwim__end_sorting(&w->memory, &sorting);
    return good;
}

static int pbwm3__compare_places(const void *a, const void *b)
{
    const pbwm3__place *x = (const pbwm3__place *)a, *y = (const pbwm3__place *)b;
    int k;
    if (x->distance < y->distance || x->distance > y->distance) {
        return x->distance < y->distance ? 1 : -1;
    }
    for (k = 0; k < 2 && !(x->p[k] < y->p[k] || x->p[k] > y->p[k]); k++) {
    }
    return (x->p[k] > y->p[k]) - (x->p[k] < y->p[k]);
}

/* Halves the size around a place that needs a point, but not below the finest; a cell's once each time. */
static void pbwm3__halve_size(pbwm3__work *w, const double p[3])
{
    const size_t cell = pbwm3__field_cell(w, p);
    double *size = w->field.at + cell;
    if (w->halved.at[cell] < w->halvings && *size > w->finest) {
        *size = fmax(w->finest, *size / 2);
        w->halved.at[cell] = (unsigned char)w->halvings;
        w->cells_halved++;
    }
}

/* Adds points at the places that are too far from the boundary, the farthest first; or halves the sizes there.
   Returns how many points, -1 without memory or if the call is cancelled. */
static long pbwm3__add_places(pbwm3__work *w, pbwm3__place_list *places, int halve)
{
    pbwm3__place *place = places->at;
    size_t i, away = 0;
    long added = 0;
    int got = 0;
    for (i = 0; i < places->count; i++) {
        if (place[i].distance > w->distance * w->size) {
            place[away++] = place[i];
        }
    }
    if (away > 0) {
        qsort(place, away, sizeof *place, pbwm3__compare_places);
    }
    for (i = 0; i < away && got >= 0 && !w->cancelled; i++) {
        double p[3];
        size_t patch;
        (void)pbwm3__ends_at(w, i, 64);              /* however late it is, the points of a round are added */
        memcpy(p, place[i].p, sizeof p);
        patch = pbwm3__to_surface(w, p);
        got = pbwm3__add_if_far(w, p, PBWM3__TIP, patch, 0.3, 0.25);
        added += got;
        if (halve && got == 0 && place[i].distance > PBWM3__TIP_DISTANCE * w->distance * w->size) {
            pbwm3__halve_size(w, p);
        }
    }
    return got < 0 || w->cancelled ? -1 : added;
}

/* Adds points where the surface is far from the boundary, or halves the sizes there; *added: how many points. */
static pbw_status pbwm3__cover_surface(pbwm3__work *w, int halve, long *added)
{
    pbwsf__triples facets = { NULL, 0, 0 };
    pbwm3__place_list list = { NULL, 0, 0 };
    pbwsf__flags chained = { NULL, 0, 0 };
    pbw_surface boundary;
    pbwm3__places places;
    pbw_status status = PBW_ERROR_MEMORY;
    memset(&boundary, 0, sizeof boundary);
    if (PBW_FIT(&w->memory, chained, w->surface.point_count + 1)) {
        memset(chained.at, 0, chained.capacity * sizeof *chained.at);
        pbwm3__mark_chains(w, chained.at);
        if (pbwm3__list_places(w, chained.at, &list)
            && pbwm3__list_boundary(w, &facets, NULL)) {
            status = pbwm3__make_surface(w, w->x.at[0], w->x.count, (const pbw_index *)facets.at,
                                         facets.count, &boundary);
        }
    }
    places.boundary = &boundary;
    places.place = list.at;
    places.enough = w->distance * w->size;
    status = status != PBW_OK ? status
           : pbw_for(pbwm3__inner_options(w), list.count, 256, pbwm3__place_range, &places);
    if (status == PBW_OK) {
        *added = pbwm3__add_places(w, &list, halve);
        status = *added < 0 ? PBW_ERROR_MEMORY : PBW_OK;
    }
    pbwm3__drop_surface(w, &boundary);
    PBW_RELEASE(&w->memory, facets);
    PBW_RELEASE(&w->memory, list);
    PBW_RELEASE(&w->memory, chained);
    return status;
}

/* Counts the faults of the boundary before improvement. */
static pbw_status pbwm3__count_faults(pbwm3__work *w)
{
    pbwm3__topology top;
    pbw_status status;
    memset(&top, 0, sizeof top);
    status = pbwm3__find_faults(w, &top);
    PBW_RELEASE(&w->memory, top.edges);
    PBW_RELEASE(&w->memory, top.flags);
    return status;
}

/* Copies the points, so that they can be put back.  Returns 0 without memory. */
static int pbwm3__keep_points(pbwm3__work *w)
{
    pbwm3__points *kept = &w->kept;
    const size_t points = w->x.count, pieces = w->pieces.count;
    if (!PBW_FIT(&w->memory, kept->x, points) || !PBW_FIT(&w->memory, kept->kind, points)
        || !PBW_FIT(&w->memory, kept->set, points) || !PBW_FIT(&w->memory, kept->pieces, pieces + 1)) {
        return 0;
    }
    memcpy(kept->x.at, w->x.at, points * sizeof *w->x.at);
    memcpy(kept->kind.at, w->kind.at, points);
    memcpy(kept->set.at, w->set.at, points * sizeof *w->set.at);
    if (pieces > 0) {
        memcpy(kept->pieces.at, w->pieces.at, pieces * sizeof *w->pieces.at);
    }
    kept->x.count = points;
    kept->pieces.count = pieces;
    kept->faults = w->report->bad_edges + w->report->bad_points;
    kept->missing_edges = w->report->missing_edges;
    return 1;
}

/* Puts the points back that were kept.  The spacing grid is not: no more are added. */
static pbw_status pbwm3__put_back(pbwm3__work *w)
{
    const pbwm3__points *kept = &w->kept;
    w->x.count = w->kind.count = w->moved.count = w->links.count = w->set.count = kept->x.count;
    memset(w->moved.at, 1, w->moved.count);
    w->pieces.count = kept->pieces.count;
    memcpy(w->x.at, kept->x.at, w->x.count * sizeof *w->x.at);
    memcpy(w->kind.at, kept->kind.at, w->x.count);
    memcpy(w->set.at, kept->set.at, w->x.count * sizeof *w->set.at);
    if (w->pieces.count > 0) {
        memcpy(w->pieces.at, kept->pieces.at, w->pieces.count * sizeof *w->pieces.at);
    }
    w->report->missing_edges = kept->missing_edges;
    w->report->settled = 1;
    return pbwm3__rebuild(w);
}

/* Halves the sizes at tips that are too far from the boundary, when no point is left to add.  Returns whether it
   changed one. */
static pbw_status pbwm3__halve_sizes(pbwm3__work *w, long *changed)
{
    const size_t cells = w->n[0] * w->n[1] * w->n[2];
    pbw_status status = PBW_OK;
    size_t i;
    if (w->halvings++ == 0) {
        status = pbwm3__count_faults(w);
        if (status == PBW_OK && !(PBW_ZEROS(&w->memory, w->halved, cells) && pbwm3__keep_points(w))) {
            status = PBW_ERROR_MEMORY;
        }
    }
    if (status != PBW_OK) {
        return status;
    }
    w->cells_halved = 0;
    status = pbwm3__cover_surface(w, 1, changed);
    for (i = 0; w->cells_halved > 0 && i < cells; i++) {
        w->least = fmin(w->least, w->field.at[i]);
    }
    if (w->cells_halved > 0) {
        pbwm3__grade(w);
        memset(w->moved.at, 1, w->moved.count);      /* what is known was so for other sizes */
        *changed += 1;
    }
    return status;
}

enum { PBWM3__ROUNDS = 16, PBWM3__MORE_ROUNDS = 24, PBWM3__HALVINGS = 2 };       /* by default; with halvings */

static pbw_status pbwm3__rounds(pbwm3__work *w)
{
    int most = w->how.rounds > 0 ? w->how.rounds : PBWM3__ROUNDS;
    pbw_status status = PBW_OK;
    long added = 1;
    while (status == PBW_OK) {
        w->from = w->to;
        w->to = w->from + 0.2 * (0.6 - w->from);
        status = pbwm3__rebuild(w);
        if (status != PBW_OK || w->report->rounds == most || pbwm3__is_late(w)) {
            break;
        }
        w->timed = 1;                                /* until points are added, the mesh is whole */
        status = pbwm3__status_of(w, pbwm3__list_new_points(w));
        w->timed = 0;
        if (status == PBW_OK) {
            w->report->rounds++;
            status = pbwm3__round(w, &added);
        }
        if (status == PBW_OK && added == 0) {
            w->timed = 1;
            status = pbwm3__cover_surface(w, 0, &added);
            if (status == PBW_OK && added == 0 && w->field.at != NULL && w->halvings < PBWM3__HALVINGS
                && !pbwm3__has_crossings(w)) {       /* else parts of the surface may be inside, and far for ever */
                status = pbwm3__halve_sizes(w, &added);
                most = w->how.rounds > 0 ? most : PBWM3__MORE_ROUNDS;
            }
            status = pbwm3__status_of(w, status);
            w->timed = 0;
        }
        if (status == PBW_CANCELLED && !w->cancelled) {      /* late */
            status = PBW_OK;
            break;
        }
        if (status == PBW_OK && added == 0) {
            w->report->settled = 1;
            break;
        }
    }
    status = status != PBW_OK ? status : pbwm3__count_faults(w);
    if (status == PBW_OK && w->kept.x.count > 0
        && w->report->bad_edges + w->report->bad_points > w->kept.faults) {
        status = pbwm3__put_back(w);
        status = status != PBW_OK ? status : pbwm3__count_faults(w);
    }
    status = status != PBW_OK ? status : pbwm3__reach_points(w);
    pbwm3__drop_triangulation(w, &w->last);
    PBW_RELEASE(&w->memory, w->same);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>stars        Points where the boundary is no manifold.
   In: labelled tetrahedra, after the rounds.  Out: others' labels for a few of them, so that fewer points are bad.
   At a bad point, the tetrahedra of a label are in several parts that no facets at the point connect: two cones that
   touch, say; likewise at a bad edge.  The smallest such part gets the label beside it, which joins or separates the
   others.  The labels with the fewest faults stay.  Sharp edges and corners keep theirs if the surface itself is no
   manifold, as that of two boxes that touch.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwm3__star {
    pbw_index ends[2];                     /* of an edge, or a point twice */
    pbwsf__indices tets;                   /* those there, ascending */
    pbwsf__counts part;                    /* of each of them: a tree of those that facets there connect */
    pbwsf__numbers volume;                 /* at a root: of its part */
} pbwm3__star;

/* Returns the place of a tetrahedron in the star, or their number. */
static size_t pbwm3__in_star(const pbwm3__star *star, pbw_index t)
{
    size_t low = 0, high = star->tets.count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        *(star->tets.at[middle] < t ? &low : &high) = star->tets.at[middle] < t ? middle + 1 : middle;
    }
    return low < star->tets.count && star->tets.at[low] == t ? low : star->tets.count;
}

/* Returns the tetrahedron behind facet i % 4 of the star's tetrahedron i / 4, PBW_NONE if the facet is not there. */
static pbw_index pbwm3__behind(const pbwm3__work *w, const pbwm3__star *star, size_t i)
{
    const size_t at = 4 * (size_t)star->tets.at[i / 4] + i % 4;
    const pbw_index across = w->now.mesh.simplices[at];
    return across == star->ends[0] || across == star->ends[1] ? PBW_NONE : w->now.mesh.neighbors[at];
}

/* Finds the parts of the star, and their volumes.  Returns 0 without memory. */
static int pbwm3__part_star(pbwm3__work *w, pbwm3__star *star)
{
    const size_t count = star->tets.count;
    size_t i;
    if (!pbwm3__start_trees(&w->memory, &star->part, count) || !PBW_ZEROS(&w->memory, star->volume, count)) {
        return 0;
    }
    for (i = 0; i < 4 * count; i++) {
        const pbw_index n = pbwm3__behind(w, star, i);
        if (n != PBW_NONE && w->now.label.at[star->tets.at[i / 4]] == w->now.label.at[n]) {
            pbwm3__join(star->part.at, i / 4, pbwm3__in_star(star, n));
        }
    }
    for (i = 0; i < count; i++) {
        const pbw_index *c = w->now.mesh.simplices + 4 * (size_t)star->tets.at[i];
        star->volume.at[pbwm3__root_of(star->part.at, i)] += pbw_tet_measure(PBW_MEASURE_VOLUME, w->x.at[c[0]],
            w->x.at[c[1]], w->x.at[c[2]], w->x.at[c[3]]);
    }
    return 1;
}

/* Gives the smallest part of the star, of those of a label in several parts, the label beside it.  Returns whether
   there is one. */
static int pbwm3__relabel_part(pbwm3__work *w, pbwm3__star *star)
{
    const size_t count = star->tets.count;
    const pbw_index *tet = star->tets.at;
    size_t *part = star->part.at, i, k, least = count;
    int label = 0, found = 0;
    for (i = 0; i < count; i++) {
        for (k = 0; k < count && part[i] == i && !(part[k] == k && k != i
                                                   && w->now.label.at[tet[k]] == w->now.label.at[tet[i]]); k++) {
        }
        if (part[i] == i && k < count && (least == count || star->volume.at[i] < star->volume.at[least])) {
            least = i;
        }
    }
    for (i = 0; i < 4 * count && least < count && !found; i++) {
        const pbw_index n = pbwm3__behind(w, star, i);
        if (n != PBW_NONE && pbwm3__root_of(part, i / 4) == least
            && w->now.label.at[n] != w->now.label.at[tet[i / 4]]) {
            label = w->now.label.at[n];
            found = 1;
        }
    }
    for (i = 0; i < count && found; i++) {
        if (pbwm3__root_of(part, i) == least) {
            w->now.label.at[tet[i]] = label;
        }
    }
    return found;
}

/* Relabels parts of a star while one label has several.  *changed: whether there was one.  Returns 0 without
   memory. */
static int pbwm3__mend_star(pbwm3__work *w, pbwm3__star *star, int *changed)
{
    int tries;
    for (tries = 0; tries < 4; tries++) {
        if (!pbwm3__part_star(w, star)) {
            return 0;
        }
        if (!pbwm3__relabel_part(w, star)) {
            break;
        }
        *changed = 1;
    }
    return 1;
}

/* Relabels parts of the stars of all bad edges and points; not of sharp ones, if `touches`. */
static pbw_status pbwm3__mend_stars(pbwm3__work *w, const pbwm3__topology *top, int touches, int *changed)
{
    pbwsf__counts first = { NULL, 0, 0 };
    pbwsf__indices tets = { NULL, 0, 0 };
    pbwm3__star star;
    size_t i, k;
    int good = pbwm3__list_stars(w, top->flags.at, &first, &tets);
    memset(&star, 0, sizeof star);
    for (i = 0; i < top->edges.count + w->x.count && good; i++) {
        const int is_edge = i < top->edges.count;
        const pbw_index v = (pbw_index)(i - top->edges.count);       /* if it is none */
        star.ends[0] = is_edge ? top->edges.at[i][0] : v;
        star.ends[1] = is_edge ? top->edges.at[i][1] : v;
        if ((!is_edge && !top->flags.at[v]) || (touches && w->kind.at[star.ends[0]] == PBWM3__SHARP
                                                && w->kind.at[star.ends[1]] == PBWM3__SHARP)) {
            continue;
        }
        star.tets.count = 0;
        for (k = first.at[star.ends[0]]; k < first.at[star.ends[0] + 1] && good; k++) {
            const pbw_index *c = w->now.mesh.simplices + 4 * (size_t)tets.at[k];
            good = (c[0] != star.ends[1] && c[1] != star.ends[1] && c[2] != star.ends[1] && c[3] != star.ends[1])
                || PBW_PUSH(&w->memory, star.tets, tets.at[k]);
        }
        good = good && pbwm3__mend_star(w, &star, changed);
    }
    PBW_RELEASE(&w->memory, first);
    PBW_RELEASE(&w->memory, tets);
    PBW_RELEASE(&w->memory, star.tets);
    PBW_RELEASE(&w->memory, star.part);
    PBW_RELEASE(&w->memory, star.volume);
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Relabels while faults get fewer; then the report has the faults and the missing pieces of sharp edges. */
static pbw_status pbwm3__make_manifold(pbwm3__work *w)
{
    const size_t count = w->now.mesh.simplex_count;
    size_t faults = w->report->bad_edges + w->report->bad_points, bytes = count * sizeof(int);
    pbwm3__labels best = { NULL, 0, 0 };
    pbwsf__flags found = { NULL, 0, 0 };
    pbwm3__topology top;
    pbw_status status = PBW_ERROR_MEMORY;
    int pass, changed = 1, touches = 0;
    memset(&top, 0, sizeof top);
    if (PBW_FIT(&w->memory, best, count + 1)
        && pbwm3__examine(w, w->surface.triangles, w->surface.triangle_count, w->surface.point_count, &top)) {
        memcpy(best.at, w->now.label.at, bytes);
        touches = top.bad_edges + top.bad_points > 0;
        status = pbwm3__find_faults(w, &top);
    }
    for (pass = 0; pass < 24 && changed && faults > 0 && status == PBW_OK; pass++) {
        changed = 0;
        status = pbwm3__ends(w) ? PBW_CANCELLED : pbwm3__mend_stars(w, &top, touches, &changed);
        status = status == PBW_OK ? pbwm3__find_faults(w, &top) : status;
        if (status == PBW_OK && w->report->bad_edges + w->report->bad_points < faults) {
            faults = w->report->bad_edges + w->report->bad_points;
            memcpy(best.at, w->now.label.at, bytes);
        }
    }
    if (status == PBW_OK) {
        memcpy(w->now.label.at, best.at, bytes);
        status = pbwm3__find_faults(w, &top);
        status = status == PBW_OK && !pbwm3__find_missing(w, &found) ? PBW_ERROR_MEMORY : status;
    }
    PBW_RELEASE(&w->memory, found);
    PBW_RELEASE(&w->memory, best);
    PBW_RELEASE(&w->memory, top.edges);
    PBW_RELEASE(&w->memory, top.flags);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>result       Improvement, the boundary, and the report.
   In: labelled tetrahedra.  Out: improved tetrahedra with regions; their boundary with patches; the report.
   ------------------------------------------------------------------------------------------------------ */
/* Numbers the tetrahedra of t's label that facets connect to t.  Returns the largest of them, PBW_NONE without
   memory. */
static pbw_index pbwm3__flood(pbwm3__work *w, pbw_index t, pbw_index *region, pbw_index number, pbwsf__indices *queue)
{
    pbw_index largest = t;
    double most = -1;
    size_t done;
    int i;
    region[t] = number;
    queue->count = 0;
    if (!PBW_PUSH(&w->memory, *queue, t)) {
        return PBW_NONE;
    }
    for (done = 0; done < queue->count; done++) {
        const pbw_index at = queue->at[done], *c = w->now.mesh.simplices + 4 * (size_t)at;
        const double volume = pbw_tet_measure(PBW_MEASURE_VOLUME, w->x.at[c[0]], w->x.at[c[1]],
                                              w->x.at[c[2]], w->x.at[c[3]]);
        largest = volume > most ? at : largest;
        most = fmax(most, volume);
        for (i = 0; i < 4; i++) {
            const pbw_index next = w->now.mesh.neighbors[4 * (size_t)at + (size_t)i];
            if (pbwm3__label_of(w, next) == w->now.label.at[t] && region[next] == PBW_NONE) {
                region[next] = number;
                if (!PBW_PUSH(&w->memory, *queue, next)) {
                    return PBW_NONE;
                }
            }
        }
    }
    return largest;
}

/* Sets the regions of tetrahedra inside: for each component the innermost shell around its largest tetrahedron, 0 if
   there is none. */
static int pbwm3__find_regions(pbwm3__work *w, pbwsf__indices *regions)
{
    pbwsf__indices queue = { NULL, 0, 0 };
    pbw_index *region, largest;
    size_t t, i;
    int good = PBW_FIT(&w->memory, *regions, w->now.mesh.simplex_count + 1);
    region = regions->at;
    for (t = 0; good && t < w->now.mesh.simplex_count; t++) {
        region[t] = PBW_NONE;
    }
    for (t = 0; good && t < w->now.mesh.simplex_count; t++) {
        const double *p[4];
        double middle[3];
        pbw_index number;
        if (!w->now.label.at[t] || region[t] != PBW_NONE) {
            continue;
        }
        largest = pbwm3__flood(w, (pbw_index)t, region, 0, &queue);
        good = largest != PBW_NONE;
        for (i = 0; i < 4 && good; i++) {
            p[i] = w->x.at[w->now.mesh.simplices[4 * (size_t)largest + i]];
        }
        if (good) {
            pbwm3__middle(p, middle);
            number = pbwm3__shells_around(w, middle, (size_t)-1).innermost;
            for (i = 0; i < queue.count && number != PBW_NONE; i++) {
                region[queue.at[i]] = number;
            }
        }
    }
    PBW_RELEASE(&w->memory, queue);
    return good;
}

typedef struct pbwm3__interior { pbwm3__work *w; const pbw_index *region; } pbwm3__interior;

static size_t pbwm3__list_inside(void *lists, size_t t, size_t at)
{
    const pbwm3__interior *l = (const pbwm3__interior *)lists;
    const int label = l->w->now.label.at[t];
    if (label && at != PBWM3__COUNTS) {
        memcpy(l->w->corners.at + at, l->w->now.mesh.simplices + 4 * t, sizeof *l->w->corners.at);
        l->w->regions.at[at] = l->region != NULL ? l->region[t] : l->w->walls ? (pbw_index)(label - 1) : 0;
    }
    return label != 0;
}

/* Lists the tetrahedra inside with their regions. */
static int pbwm3__fill_inside(pbwm3__work *w)
{
    pbwsf__indices regions = { NULL, 0, 0 };
    pbwm3__interior l = { w, NULL };
    pbwm3__listing listing;
    size_t count = 0;
    int good = w->walls || w->shells.count < 2 || pbwm3__find_regions(w, &regions);
    if (good) {
        l.region = regions.at;
        good = pbwm3__count_list(w, w->now.mesh.simplex_count, pbwm3__list_inside, &l, &listing, &count)
            && PBW_FIT(&w->memory, w->corners, count + 1) && PBW_FIT(&w->memory, w->regions, count + 1);
        good = pbwm3__write_list(w, &listing, good);
        w->corners.count = good ? count : 0;
    }
    PBW_RELEASE(&w->memory, regions);
    return good;
}

enum { PBWM3__FEW = 500 };                 /* if fewer than one of so many is bad, points that are fixed may be why */

/* Improves once more: only points on sharp edges stay, others may slide, which were tips or seemed to be features. */
static pbw_status pbwm3__improve_again(pbwm3__work *w, const pbw_improve_options *improve, pbw_options *own,
                                       pbw_tets *out)
{
    pbw_improve_report *sum = &w->report->improve, more;
    pbw_tets in = *out, better;
    pbwsf__flags marks = { NULL, 0, 0 };
    pbw_status status;
    size_t i, freed = 0;
    if (!PBW_FIT(&w->memory, marks, in.point_count)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < in.point_count; i++) {
        const int sharp = in.original[i] != PBW_NONE && w->kind.at[in.original[i]] == PBWM3__SHARP;
        marks.at[i] = sharp ? PBW_TETS_FIXED : PBW_TETS_FOUND;
        freed += !sharp && in.marks[i] == PBW_TETS_FIXED;
    }
    if (freed == 0) {
        PBW_RELEASE(&w->memory, marks);
        return PBW_OK;
    }
    in.marks = marks.at;
    w->from = w->to;                                 /* its progress was the first one's */
    own->memory_limit = pbw_memory_left(&w->memory);
    status = pbw_improve(&in, improve, own, &better, &more);
    PBW_RELEASE(&w->memory, marks);
    if (status == PBW_OK) {
        pbw_index *original = (pbw_index *)better.original;
        for (i = 0; i < better.point_count; i++) {
            original[i] = original[i] != PBW_NONE ? in.original[original[i]] : PBW_NONE;
        }
        w->memory.used += pbwim__result_bytes(&better) - pbwim__result_bytes(out);
        pbw_tets_free(out);
        *out = better;
        sum->after = more.after;
        sum->left = more.left;
        sum->passes += more.passes;
    }
    return status;
}

static pbw_status pbwm3__improve(pbwm3__work *w, pbw_tets *out)
{
    pbw_improve_options improve = w->how.improve;
    pbw_options own = w->options;
    pbw_status status;
    pbw_tets in;
    size_t i;
    memset(&in, 0, sizeof in);
    if (!pbwm3__fill_inside(w) || !PBW_FIT(&w->memory, w->marks, w->x.count + 1)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < w->x.count; i++) {
        w->marks.at[i] = w->kind.at[i] <= PBWM3__TIP ? PBW_TETS_FIXED : PBW_TETS_FOUND;
    }
    if (w->corners.count == 0) {
        return PBW_DEGENERATE;
    }
    pbwm3__drop_mesh(w, &w->now.mesh);
    in.points = w->x.at[0];
    in.point_count = w->x.count;
    in.corners = w->corners.at[0];
    in.tet_count = w->corners.count;
    in.regions = w->regions.at;
    in.marks = w->marks.at;
    improve.feature_angle = improve.feature_angle > 0 ? improve.feature_angle : 75;      /* features are marked */
    improve.project = pbwm3__project;
    improve.project_user = w;
    improve.distance = improve.distance > 0 ? improve.distance : 1.48 * w->distance * w->size;
    improve.passes = improve.target < 0 ? -1 : improve.passes;
    improve.target = improve.target < 0 ? 0 : improve.target;
    improve.seconds = w->deadline < HUGE_VAL ? fmax(1e-9, w->deadline - (double)clock() / CLOCKS_PER_SEC) : 0;
    own.progress = pbwm3__part_progress;
    own.progress_user = w;
    own.memory_limit = pbw_memory_left(&w->memory);
    status = pbw_improve(&in, &improve, &own, out, &w->report->improve);
    w->memory.used += pbwim__result_bytes(out);
    if (status == PBW_OK && w->report->improve.left > 0 && improve.passes >= 0 && !pbwm3__is_late(w)
        && w->report->improve.left < out->tet_count / PBWM3__FEW) {
        improve.feature_angle = w->how.improve.feature_angle > 0 ? improve.feature_angle : 180;
        status = pbwm3__improve_again(w, &improve, &own, out);
    }
    return status;
}

enum { PBWM3__DISTANCES = 256 };           /* triangles of a range */

/* How far triangles are from a surface. */
typedef struct pbwm3__distances {
    const double *points;
    const pbw_index *triangles;
    const pbw_surface *surface;
    int paired;                            /* 1: each edge has two triangles, which run along it in opposite ways */
    unsigned char *seen;                   /* per point: 1, a triangle has it measured */
    double *distance;                      /* per range: the largest, of middles, middles of edges, and corners */
} pbwm3__distances;

/* Makes place k of a triangle: its middle, those of its edges, its corners.  Returns 0 if another triangle has it. */
static int pbwm3__distance_place(const pbwm3__distances *away, size_t triangle, int k, double p[3])
{
    const pbw_index *v = away->triangles + 3 * triangle;
    const double *c[3];
    int j;
    for (j = 0; j < 3; j++) {
        c[j] = away->points + 3 * (size_t)v[j];
    }
    for (j = 0; j < 3; j++) {
        p[j] = k == 0 ? (c[0][j] + c[1][j] + c[2][j]) / 3 : k < 4 ? (c[k - 1][j] + c[k % 3][j]) / 2 : c[k - 4][j];
    }
    if (k > 3) {
        unsigned char *seen = away->seen + v[k - 4];
        if (PBW_ATOMIC_LOAD(seen)) {
            return 0;
        }
        PBW_ATOMIC_STORE(seen, 1);
    }
    return k == 0 || k > 3 || !away->paired || v[k - 1] < v[k % 3];
}

static pbw_status pbwm3__distance_range(void *arg, size_t from, size_t to)
{
    const pbwm3__distances *away = (const pbwm3__distances *)arg;
    pbw_index nearby = PBW_NONE;                     /* the triangle that is nearest to the place before */
    double most = 0;
    size_t i;
    int k;
    for (i = from; i < to; i++) {
        for (k = 0; k < 7; k++) {
            double p[3], place[3];
            if (pbwm3__distance_place(away, i, k, p) && !pbwm3__triangle_is_near(away->surface, nearby, p, most)) {
                nearby = pbwsf__closest(away->surface, p, HUGE_VAL, most, place);
                most = nearby == PBW_NONE ? most : fmax(most, pbwsf__distance(p, place));
            }
        }
    }
    away->distance[from / PBWM3__DISTANCES] = most;
    return PBW_OK;
}

/* Raises *least to the largest distance of the triangles, at so many points, from the surface. */
static pbw_status pbwm3__farthest(pbwm3__work *w, pbwm3__distances *away, size_t points, size_t count, double *least)
{
    const size_t ranges = (count + PBWM3__DISTANCES - 1) / PBWM3__DISTANCES;
    pbwsf__numbers room = { NULL, 0, 0 };
    pbwsf__flags seen = { NULL, 0, 0 };
    pbw_options options = w->options;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i;
    options.progress = pbwm3__part_progress;
    options.progress_user = w;
    if (PBW_FIT(&w->memory, room, ranges + 1) && PBW_ZEROS(&w->memory, seen, points)) {
        away->distance = room.at;
        away->seen = seen.at;
        status = pbw_for(&options, count, PBWM3__DISTANCES, pbwm3__distance_range, away);
        for (i = 0; status == PBW_OK && i < ranges; i++) {
            *least = fmax(*least, away->distance[i]);
        }
    }
    PBW_RELEASE(&w->memory, room);
    PBW_RELEASE(&w->memory, seen);
    return status;
}

static void pbwm3__list_bad_places(pbw_solid_report *r, const pbwm3__topology *top, const pbw_tets *out)
{
    size_t i, count = 0;
    for (i = 0; i < top->edges.count && count < PBW_SOLID_PLACES; i++) {
        const pbw_index *end = top->edges.at[i];
        pbwsf__between(out->points + 3 * (size_t)end[0], out->points + 3 * (size_t)end[1], 0.5, r->places[count++]);
    }
    for (i = 0; i < out->point_count && count < PBW_SOLID_PLACES; i++) {
        if (top->flags.at[i]) {
            memcpy(r->places[count++], out->points + 3 * i, sizeof *r->places);
        }
    }
}

/* ---- the boundary of the result ---- */

typedef struct pbwm3__boundary_arrays {    /* boundary.memory points at them */
    pbw_memory memory;
    pbwsf__triples facets;
    pbwsf__indices corners, patches, parts;
    pbwsf__pairs sides, edges;
    PBW_ARRAY(pbw_solid_hole) holes;
} pbwm3__boundary_arrays;

/* Facets of the result, out of its regions: between two, out of that with the smaller shell. */
typedef struct pbwm3__result_facets {
    const pbw_tets *out;
    const pbwm3__shell *shell;
    pbwm3__boundary_arrays *arrays;
} pbwm3__result_facets;

static size_t pbwm3__list_sides(void *lists, size_t t, size_t at)
{
    const pbwm3__result_facets *b = (const pbwm3__result_facets *)lists;
    const pbw_index *corner = b->out->corners + 4 * t, in = b->out->regions[t];
    const double volume = fabs(b->shell[in].volume);
    size_t count = 0, i, k;
    for (i = 0; i < 4; i++) {
        const pbw_index next = b->out->neighbors[4 * t + i];
        const pbw_index other = next == PBW_NONE ? PBW_NONE : b->out->regions[next];
        const double behind = next == PBW_NONE || other == in ? 0 : fabs(b->shell[other].volume);
        if (other == in || (next != PBW_NONE && (volume > behind || (!(volume < behind) && in > other)))) {
            continue;
        }
        if (at != PBWM3__COUNTS) {
            for (k = 0; k < 3; k++) {
                b->arrays->facets.at[at + count][k] = corner[pbwim__opposite[i][2 - k]];
            }
            b->arrays->sides.at[at + count][0] = in;
            b->arrays->sides.at[at + count][1] = other;
            b->arrays->corners.at[at + count] = (pbw_index)(4 * t + i);
        }
        count++;
    }
    return count;
}

static int pbwm3__list_result_facets(pbwm3__work *w, const pbw_tets *out, pbwm3__boundary_arrays *arrays)
{
    pbwm3__result_facets b = { out, w->shells.at, arrays };
    pbwm3__listing listing;
    size_t count = 0;
    int good = pbwm3__count_list(w, out->tet_count, pbwm3__list_sides, &b, &listing, &count)
            && PBW_FIT(&w->memory, arrays->facets, count + 1) && PBW_FIT(&w->memory, arrays->sides, count + 1)
            && PBW_FIT(&w->memory, arrays->corners, count + 1);
    good = pbwm3__write_list(w, &listing, good);
    arrays->facets.count = arrays->sides.count = arrays->corners.count = good ? count : 0;
    return good;
}

/* Appends the patch and the part of a facet: those of the triangle nearest to its middle. */
static int pbwm3__place_facet(pbwm3__work *w, const double *points, const pbw_index *f,
                              pbwm3__boundary_arrays *arrays)
{
    double middle[3], place[3];
    pbw_index t, part, patch;
    int k;
    for (k = 0; k < 3; k++) {
        middle[k] = (points[3 * (size_t)f[0] + (size_t)k] + points[3 * (size_t)f[1] + (size_t)k]
                     + points[3 * (size_t)f[2] + (size_t)k]) / 3;
    }
    t = pbw_surface_closest(&w->surface, middle, w->open ? w->size / 2 : HUGE_VAL, place);
    part = t == PBW_NONE ? PBW_NONE : w->part.at[t];
    patch = t == PBW_NONE || (w->input->value == NULL && t >= w->first_closing) ? PBW_NONE
          : w->input->value == NULL && w->input->patches != NULL ? pbwm3__patch_of(w, t) : part;
    return PBW_PUSH(&w->memory, arrays->patches, patch)
        && PBW_PUSH(&w->memory, arrays->parts, part);
}

/* Returns whether two points of the result are the ends of a piece of a sharp edge; the pieces are sorted. */
static int pbwm3__is_piece(const pbwm3__work *w, const pbw_tets *out, const pbw_index *pair)
{
    pbwm3__piece key;
    key.a = out->original[pair[0]];
    key.b = out->original[pair[1]];
    return key.a != PBW_NONE && key.b != PBW_NONE && w->pieces.count > 0
        && bsearch(&key, w->pieces.at, w->pieces.count, sizeof key, pbwm3__compare_pieces) != NULL;
}

static int pbwm3__list_edges(pbwm3__work *w, const pbw_tets *out, pbwm3__boundary_arrays *arrays)
{
    pbwim__sorting sorting;
    const size_t count = 3 * arrays->facets.count;
    const pbw_index *patch = arrays->patches.at;
    const pbwim__facet *edge = pbwm3__edges(w, (const pbw_index *)arrays->facets.at, arrays->facets.count,
                                            out->point_count, &sorting);
    size_t i, k;
    int good = edge != NULL;
    if (w->pieces.count > 0) {
        qsort(w->pieces.at, w->pieces.count, sizeof(pbwm3__piece), pbwm3__compare_pieces);
    }
    for (i = 0; good && i < count; i = k) {
        int feature = pbwm3__is_piece(w, out, edge[i].v);
        for (k = i + 1; k < count && memcmp(edge[i].v, edge[k].v, 2 * sizeof(pbw_index)) == 0; k++) {
            feature |= patch[edge[k].t] != patch[edge[i].t];
        }
        good = !feature || PBWM3__APPEND(w, arrays->edges, edge[i].v);
    }
    pbwim__end_sorting(&w->memory, &sorting);
    return good;
}

static int pbwm3__fill_boundary(pbwm3__work *w, const pbw_tets *out, pbwm3__boundary_arrays *arrays)
{
    size_t i;
    for (i = 0; i < arrays->facets.count; i++) {
        if (pbwm3__ends_at(w, i, 1024) || !pbwm3__place_facet(w, out->points, arrays->facets.at[i], arrays)) {
            return 0;
        }
    }
    for (i = 0; i < w->holes.count; i++) {
        if (!PBW_PUSH(&w->memory, arrays->holes, w->holes.at[i])) {
            return 0;
        }
    }
    return pbwm3__list_edges(w, out, arrays);
}

static void pbwm3__release_boundary(pbw_memory *memory, pbwm3__boundary_arrays *arrays)
{
    PBW_RELEASE(memory, arrays->facets);
    PBW_RELEASE(memory, arrays->corners);
    PBW_RELEASE(memory, arrays->patches);
    PBW_RELEASE(memory, arrays->parts);
    PBW_RELEASE(memory, arrays->sides);
    PBW_RELEASE(memory, arrays->edges);
    PBW_RELEASE(memory, arrays->holes);
}

PBWDEF void pbw_solid_boundary_free(pbw_solid_boundary *boundary)
{
    if (boundary != NULL && boundary->memory != NULL) {
        pbwm3__boundary_arrays *arrays = (pbwm3__boundary_arrays *)boundary->memory;
        pbw_memory memory = arrays->memory;
        pbwm3__release_boundary(&memory, arrays);
        (void)pbw_memory_resize(&memory, arrays, 1, 0, sizeof *arrays);
    }
    if (boundary != NULL) {
        memset(boundary, 0, sizeof *boundary);
    }
}

/* Moves the arrays to the caller's boundary. */
static pbw_status pbwm3__export_boundary(pbwm3__work *w, pbwm3__boundary_arrays *arrays, pbw_solid_boundary *boundary)
{
    pbwm3__boundary_arrays *own = (pbwm3__boundary_arrays *)pbw_memory_resize(&w->memory, NULL, 0, 1, sizeof *own);
    if (own == NULL) {
        return PBW_ERROR_MEMORY;
    }
    arrays->memory = w->memory;
    *own = *arrays;
    boundary->memory = own;
    boundary->facet_count = arrays->facets.count;
    boundary->edge_count = arrays->edges.count;
    boundary->hole_count = arrays->holes.count;
    boundary->facets = (const pbw_index *)arrays->facets.at;
    boundary->corners = arrays->corners.at;
    boundary->patches = arrays->patches.at;
    boundary->parts = arrays->parts.at;
    boundary->sides = (const pbw_index *)arrays->sides.at;
    boundary->edges = (const pbw_index *)arrays->edges.at;
    boundary->holes = arrays->holes.at;
    memset(arrays, 0, sizeof *arrays);
    return PBW_OK;
}

/* How many regions the result has: numbers of shells that occur. */
static void pbwm3__count_regions(pbwm3__work *w, const pbw_tets *out)
{
    pbwm3__shell *shell = w->shells.at;
    size_t i;
    for (i = 0; i < out->tet_count; i++) {
        w->report->regions += shell[out->regions[i]].seen == 0;
        shell[out->regions[i]].seen = 1;
    }
}

/* Examines the boundary; with walls that of each region, whose facets out->neighbors tell. */
static int pbwm3__examine_result(pbwm3__work *w, const pbw_tets *out, const pbwsf__triples *facets,
                                 pbwm3__topology *top)
{
    pbwsf__triples all = { NULL, 0, 0 };
    pbwm3__labels labels = { NULL, 0, 0 };
    size_t i, k;
    int good = 1;
    if (!w->walls) {
        return pbwm3__examine(w, (const pbw_index *)facets->at, facets->count, out->point_count, top);
    }
    for (i = 0; good && i < 4 * out->tet_count; i++) {
        const int label = (int)out->regions[i / 4] + 1;
        pbw_index f[3];
        if (out->neighbors[i] == PBW_NONE || out->regions[out->neighbors[i]] != out->regions[i / 4]) {
            for (k = 0; k < 3; k++) {
                f[k] = out->corners[i / 4 * 4 + (size_t)pbwim__opposite[i % 4][2 - k]];
            }
            good = PBWM3__APPEND(w, all, f) && PBW_PUSH(&w->memory, labels, label);
        }
    }
    good = good && pbwm3__examine_labels(w, &all, &labels, out->point_count, top);
    PBW_RELEASE(&w->memory, all);
    PBW_RELEASE(&w->memory, labels);
    return good;
}

/* Fills the report of the boundary's facets. */
static pbw_status pbwm3__report_boundary(pbwm3__work *w, const pbw_tets *out, const pbwsf__triples *facets)
{
    pbw_solid_report *r = w->report;
    const pbw_index *facet = (const pbw_index *)facets->at;
    pbwm3__topology top;
    pbw_surface boundary;
    pbwm3__distances away;
    pbw_status status = PBW_ERROR_MEMORY;
    double distance = 0;
    memset(&top, 0, sizeof top);
    memset(&boundary, 0, sizeof boundary);
    r->facets = facets->count;
    if (pbwm3__examine_result(w, out, facets, &top)) {
        status = pbwm3__make_surface(w, out->points, out->point_count, facet, facets->count, &boundary);
    }
    if (status == PBW_OK) {
        r->bad_edges = top.bad_edges;
        r->bad_points = top.bad_points;
        r->euler = top.euler;
        pbwm3__list_bad_places(r, &top, out);
        away.points = out->points;
        away.triangles = facet;
        away.surface = &w->surface;
        away.paired = !w->walls;
        status = pbwm3__farthest(w, &away, out->point_count, facets->count, &distance);
    }
    if (status == PBW_OK && !w->joined) {            /* else parts of the surface are inside */
        away.points = w->surface.points;
        away.triangles = w->surface.triangles;
        away.surface = &boundary;
        away.paired = !w->walls && !w->open && !w->twisted;
        w->from = w->to;
        w->to = 1;
        status = pbwm3__farthest(w, &away, w->surface.point_count, w->surface.triangle_count, &distance);
    }
    r->distance = distance / w->size;
    pbwm3__drop_surface(w, &boundary);
    PBW_RELEASE(&w->memory, top.edges);
    PBW_RELEASE(&w->memory, top.flags);
    return status;
}

static pbw_status pbwm3__measure(pbwm3__work *w, const pbw_tets *out, pbw_solid_boundary *boundary)
{
    pbwm3__boundary_arrays arrays;
    pbw_status status = PBW_ERROR_MEMORY;
    memset(&arrays, 0, sizeof arrays);
    pbwm3__count_regions(w, out);
    if (pbwm3__list_result_facets(w, out, &arrays)) {
        status = pbwm3__report_boundary(w, out, &arrays.facets);
    }
    if (status == PBW_OK && boundary != NULL) {
        status = !pbwm3__fill_boundary(w, out, &arrays) ? PBW_ERROR_MEMORY
               : pbwm3__export_boundary(w, &arrays, boundary);
    }
    pbwm3__release_boundary(&w->memory, &arrays);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>stages       All of it in order.
   In: what the caller gives.  Out: the result, of the better of two attempts.
   ------------------------------------------------------------------------------------------------------ */
/* Refuses surfaces that are mostly holes, or walls too thin for the size, and sizes that need too many tetrahedra. */
static pbw_status pbwm3__check_input(pbwm3__work *w)
{
    pbw_solid_report *r = w->report;
    const double h = w->size, volume = fabs(r->input_volume);
    double area = 0;
    size_t i;
    for (i = 0; i < w->triangles.count; i++) {
        double n[3];
        pbwsf__normal_of(&w->surface, (pbw_index)i, n);
        area += sqrt(pbwsf__dot(n, n)) / 2;
    }
    r->thickness = area > 0 ? 2 * volume / area / h : 0;
    r->estimate = 5 * volume / h / h / h + 8 * area / h / h;
    r->refusal = w->input->value == NULL && !w->how.close && r->hole_share > 0.34 ? PBW_SOLID_OPEN
               : w->input->value == NULL && !w->how.close && !w->open && !w->walls
                 && r->thickness < (r->holes > 0 ? 0.2 : 0.09) ? PBW_SOLID_THIN
               : r->estimate > (w->how.most > 0 ? w->how.most : 5e7) ? PBW_SOLID_LARGE : PBW_SOLID_FILLED;
    return r->refusal == PBW_SOLID_LARGE ? PBW_ERROR_TOO_LARGE
         : r->refusal != PBW_SOLID_FILLED ? PBW_DEGENERATE : PBW_OK;
}

static pbw_status pbwm3__take_input(pbwm3__work *w)
{
    const pbw_solid_input *in = w->input;
    pbw_status status;
    size_t i;
    int k;
    for (k = 0; k < 3; k++) {
        w->low[k] = in->value != NULL ? in->box[k] : HUGE_VAL;
        w->high[k] = in->value != NULL ? in->box[3 + k] : -HUGE_VAL;
    }
    for (i = 0; i < 3 * in->point_count && in->value == NULL; i++) {
        if (!(fabs(in->points[i]) <= 1e100)) {
            return PBW_ERROR_NOT_FINITE;
        }
    }
    for (i = 0; i < 3 * in->triangle_count && in->value == NULL; i++) {
        for (k = 0; k < 3 && in->triangles[i] < in->point_count; k++) {
            const double x = in->points[3 * (size_t)in->triangles[i] + (size_t)k];
            w->low[k] = fmin(w->low[k], x);
            w->high[k] = fmax(w->high[k], x);
        }
    }
    if (in->value == NULL && in->triangle_count == 0) {
        return PBW_DEGENERATE;
    }
    w->size = w->how.size > 0 ? w->how.size : pbwsf__distance(w->low, w->high) / 40;
    w->floor = fmin(w->size, w->how.least_size > 0 ? w->how.least_size : w->size / (w->how.size_at != NULL ? 16 : 6));
    w->finest = w->how.least_size > 0 ? w->floor : fmin(w->floor, w->size / 12);
    if (!(w->size > 0 && w->size < HUGE_VAL)) {
        return in->value != NULL ? PBW_ERROR_ARGUMENT : PBW_DEGENERATE;
    }
    w->report->size = w->size;
    w->report->least_angle = 180;
    status = in->value != NULL ? pbwm3__take_function(w) : pbwm3__take_triangles(w, in);
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        return status;
    }
    if (w->triangles.count == 0) {
        return PBW_DEGENERATE;
    }
    if ((in->value == NULL && !pbwm3__drop_doubles(w)) || !pbwm3__find_shells(w)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbwm3__make_surface(w, w->vertices.at[0], w->vertices.count, w->triangles.at[0], w->triangles.count,
                                 &w->surface);
    if (status == PBW_OK) {
        pbwm3__nest_shells(w);
        status = in->value == NULL ? pbwm3__find_crossings(w) : PBW_OK;
        status = status == PBW_OK && w->joined ? pbwm3__unite(w) : status;
        status = status != PBW_OK ? status : pbwm3__check_input(w);
    }
    if (status == PBW_OK) {
        status = w->walls && !pbwm3__measure_walls(w) ? PBW_ERROR_MEMORY : PBW_OK;
    }
    return status;
}

static pbw_status pbwm3__sample(pbwm3__work *w)
{
    pbw_status status = pbwm3__find_chains(w);
    w->timed = 1;                                    /* from now on: the report has the input's part */
    if (w->report->sharp == PBW_SOLID_SHARP_NONE && !(w->how.least_size > 0) && w->how.size_at == NULL) {
        w->floor = w->size / 3;                      /* details of a scan are noise */
    }
    status = status != PBW_OK ? status : pbwm3__make_field(w);
    if (status != PBW_OK) {
        return status;
    }
    if (w->how.plan != NULL && w->begin <= 0) {      /* the first attempt */
        w->how.plan(w->how.plan_user, w->report);
    }
    w->step = sqrt(w->least * w->mean);              /* few points a cell, and few cells around coarse ones */
    w->cells = 1 << 12;
    while ((double)w->cells < 2e6 && (double)w->cells * w->step * w->step * w->step
           < 2 * (w->high[0] - w->low[0]) * (w->high[1] - w->low[1]) * (w->high[2] - w->low[2])) {
        w->cells *= 2;
    }
    if (!PBW_FIT(&w->memory, w->heads, w->cells)) {
        return PBW_ERROR_MEMORY;
    }
    memset(w->heads.at, 0xff, w->heads.capacity * sizeof *w->heads.at);
    status = pbwm3__sample_sharp(w);
    status = status != PBW_OK ? status : pbwm3__sample_smooth(w);
    return status != PBW_OK ? status : pbwm3__sample_inside(w);
}

static void pbwm3__free(pbwm3__work *w)
{
    pbwm3__drop_triangulation(w, &w->now);
    pbwm3__drop_triangulation(w, &w->last);
    PBW_RELEASE(&w->memory, w->moved);
    PBW_RELEASE(&w->memory, w->same);
    pbwm3__drop_surface(w, &w->surface);
    PBW_RELEASE(&w->memory, w->field);
    PBW_RELEASE(&w->memory, w->halved);
    PBW_RELEASE(&w->memory, w->kept.x);
    PBW_RELEASE(&w->memory, w->kept.kind);
    PBW_RELEASE(&w->memory, w->kept.set);
    PBW_RELEASE(&w->memory, w->kept.pieces);
    PBW_RELEASE(&w->memory, w->vertices);
    PBW_RELEASE(&w->memory, w->crossing);
    PBW_RELEASE(&w->memory, w->segments);
    PBW_RELEASE(&w->memory, w->planes);
    PBW_RELEASE(&w->memory, w->cuts);
    PBW_RELEASE(&w->memory, w->triangles);
    PBW_RELEASE(&w->memory, w->origin);
    PBW_RELEASE(&w->memory, w->shell);
    PBW_RELEASE(&w->memory, w->shells);
    PBW_RELEASE(&w->memory, w->sides);
    PBW_RELEASE(&w->memory, w->outer);
    PBW_RELEASE(&w->memory, w->holes);
    PBW_RELEASE(&w->memory, w->x);
    PBW_RELEASE(&w->memory, w->kind);
    PBW_RELEASE(&w->memory, w->part);
    PBW_RELEASE(&w->memory, w->patch);
    PBW_RELEASE(&w->memory, w->firsts);
    PBW_RELEASE(&w->memory, w->sets);
    PBW_RELEASE(&w->memory, w->members);
    PBW_RELEASE(&w->memory, w->set);
    PBW_RELEASE(&w->memory, w->heads);
    PBW_RELEASE(&w->memory, w->links);
    PBW_RELEASE(&w->memory, w->pieces);
    PBW_RELEASE(&w->memory, w->chains);
    PBW_RELEASE(&w->memory, w->path);
    PBW_RELEASE(&w->memory, w->new_points);
    PBW_RELEASE(&w->memory, w->corners);
    PBW_RELEASE(&w->memory, w->marks);
    PBW_RELEASE(&w->memory, w->regions);
}

/* Returns whether the options are numbers that sizes, angles and limits can be. */
static int pbwm3__are_options(const pbw_solid_options *how)
{
    size_t i;
    for (i = 0; how->region_sizes != NULL && i < how->region_size_count; i++) {
        if (!(how->region_sizes[i] >= 0 && how->region_sizes[i] < HUGE_VAL)) {
            return 0;
        }
    }
    return how->size >= 0 && how->distance >= 0 && how->least_size >= 0 && how->curvature >= 0 && how->gradation >= 0
        && how->most >= 0 && (unsigned)how->sharp <= PBW_SOLID_SHARP_NONE;
}

static double pbwm3__lap(double *since)
{
    const double now = (double)clock() / CLOCKS_PER_SEC, lap = now - *since;
    *since = now;
    return lap;
}

typedef struct pbwm3__call {               /* what the caller gave */
    const pbw_solid_input *input;
    const pbw_solid_options *how;
    const pbw_options *options;
    size_t held;                           /* bytes, when an attempt begins */
    double deadline;                       /* the processor time by which the work ends with what it has */
} pbwm3__call;

typedef struct pbwm3__result {
    pbw_tets mesh;
    pbw_solid_boundary boundary;
    pbw_solid_report report;
    int with_boundary;
} pbwm3__result;

static void pbwm3__free_result(pbwm3__result *r)
{
    if (r->mesh.memory != NULL) {
        pbw_tets_free(&r->mesh);
    }
    pbw_solid_boundary_free(&r->boundary);
}

/* An attempt up to its rounds.  whole: the surface is one patch, else sharp edges bound patches; sharp: which are
   kept; begin: of its part of the progress. */
static pbw_status pbwm3__attempt(const pbwm3__call *call, int whole, int sharp, double begin,
                                 pbw_solid_report *report, pbwm3__work *w)
{
    double since = (double)clock() / CLOCKS_PER_SEC;
    pbw_status status;
    memset(w, 0, sizeof *w);
    memset(report, 0, sizeof *report);
    report->sharp_share = -1;
    w->report = report;
    pbw_memory_start(&w->memory, call->options);
    w->memory.used = call->held;
    if (call->options != NULL) {
        w->options = *call->options;
        w->options.flags = 0;
        w->options.stride = w->options.weight_stride = 0;
        w->options.trace = NULL;
    }
    if (call->how != NULL) {
        w->how = *call->how;
    }
    w->input = call->input;
    w->caller = call->options;
    w->whole = whole;
    w->sharp = sharp;
    w->deadline = call->deadline;
    w->nested = w->how.nested != 0;
    w->begin = begin;
    w->end = begin + (begin > 0 ? 0.5 : 0.7);
    w->distance = w->how.distance > 0 ? w->how.distance : 0.1;
    w->cosine = cos((w->how.feature_angle > 0 ? w->how.feature_angle : 40) / 57.295779513082321);
    status = pbwm3__begin_stage(w, "sample", 0.1) ? PBW_CANCELLED : pbwm3__take_input(w);
    status = pbwm3__status_of(w, status != PBW_OK ? status : pbwm3__sample(w));
    w->timed = 0;
    if (status == PBW_CANCELLED && !w->cancelled) {
        report->refusal = PBW_SOLID_LATE;
    }
    report->seconds[0] = pbwm3__lap(&since);
    status = status != PBW_OK ? status : pbwm3__begin_stage(w, "rounds", 0.1) ? PBW_CANCELLED : pbwm3__rounds(w);
    report->seconds[1] = pbwm3__lap(&since);
    return pbwm3__status_of(w, status);
}

static size_t pbwm3__faults(const pbw_solid_report *r)
{
    return r->bad_edges + r->bad_points;
}

/* Makes a second attempt after one with faults or missing pieces: without sharp edges if some of them were kept, else
   with the surface as one patch.  If it has fewer, it takes the first one's place; if it fails, the first one stays,
   unless the call was cancelled or memory is short: a limit changes no result. */
static pbw_status pbwm3__second_attempt(pbwm3__call *call, pbwm3__work *w, double *done)
{
    pbw_solid_report *r = w->report, report;
    const int fewer = r->sharp == PBW_SOLID_SHARP_SOME && w->sharp == PBW_SOLID_SHARP_AUTO;
    pbwm3__work second, swap;
    pbw_status status;
    size_t faults[2];
    int k;
    if (pbwm3__faults(r) + r->missing_edges == 0 || w->open || r->sharp_edges == 0 || pbwm3__is_late(w)) {
        return PBW_OK;
    }
    call->held = w->memory.used;
    status = pbwm3__attempt(call, !fewer, fewer ? PBW_SOLID_SHARP_NONE : w->sharp, *done, &report, &second);
    *done += 0.3;
    for (k = 0; k < 2; k++) {
        report.seconds[k] += r->seconds[k];
        r->seconds[k] = report.seconds[k];
    }
    faults[0] = pbwm3__faults(r);
    faults[1] = pbwm3__faults(&report);
    if (status == PBW_OK && (faults[1] < faults[0] || (faults[1] == faults[0]
                                                       && report.missing_edges < r->missing_edges))) {
        report.sharp_share = r->sharp_share;
        *r = report;
        swap = *w;
        *w = second;
        second = swap;
        w->report = r;
        w->memory.used -= second.memory.used;
    }
    pbwm3__free(&second);
    return (status == PBW_CANCELLED && !pbwm3__is_late(w)) || status == PBW_ERROR_MEMORY ? status : PBW_OK;
}

/* Improves and measures. */
static pbw_status pbwm3__complete(pbwm3__work *w, double done, pbwm3__result *r)
{
    double since = (double)clock() / CLOCKS_PER_SEC;
    pbw_status status;
    w->end = 1;                                      /* 0.6 of this attempt are done */
    w->begin = (done - 0.6) / 0.4;
    w->to = 0.6;
    status = pbwm3__begin_stage(w, "improve", 0.9) ? PBW_CANCELLED
           : pbwm3__faults(w->report) > 0 ? pbwm3__make_manifold(w) : PBW_OK;
    status = status != PBW_OK ? status : pbwm3__improve(w, &r->mesh);
    w->report->seconds[2] = pbwm3__lap(&since);
    if (status == PBW_OK) {
        status = pbwm3__begin_stage(w, "measure", 0.95) ? PBW_CANCELLED
               : pbwm3__measure(w, &r->mesh, r->with_boundary ? &r->boundary : NULL);
        w->report->seconds[3] = pbwm3__lap(&since);
    }
    if (status != PBW_OK) {
        pbwm3__free_result(r);
    }
    return pbwm3__status_of(w, status);
}

PBWDEF pbw_status pbw_solid(const pbw_solid_input *input, const pbw_solid_options *how,
                            const pbw_options *options, pbw_tets *mesh, pbw_solid_boundary *boundary,
                            pbw_solid_report *report)
{
    pbwm3__result r;
    pbwm3__call call;
    pbwm3__work w;
    pbw_options shared;
    pbw_threads *threads;
    pbw_status status = PBW_ERROR_ARGUMENT;
    double done = 0.42;
    memset(&r, 0, sizeof r);
    r.with_boundary = boundary != NULL;
    if (mesh != NULL && input != NULL
        && (input->value != NULL || (input->points != NULL && input->triangles != NULL))
        && (how == NULL || pbwm3__are_options(how))) {
        call.input = input;
        call.how = how;
        call.options = &shared;
        call.held = 0;
        threads = pbw_threads_start(options, (size_t)1 << 20, &shared);
        call.deadline = how != NULL && how->improve.seconds > 0
                  ? (double)clock() / CLOCKS_PER_SEC + how->improve.seconds : HUGE_VAL;
        status = pbwm3__attempt(&call, 0, how != NULL ? how->sharp : PBW_SOLID_SHARP_AUTO, 0, &r.report, &w);
        status = status != PBW_OK ? status : pbwm3__second_attempt(&call, &w, &done);
        status = status != PBW_OK ? status : pbwm3__complete(&w, done, &r);
        pbwm3__free(&w);
        pbw_threads_stop(threads);
    }
    if (mesh != NULL) {
        *mesh = r.mesh;
    }
    if (boundary != NULL) {
        *boundary = r.boundary;
    }
    if (report != NULL) {
        *report = r.report;
    }
    return status;
}

PBW_CONTRACTION_ON
#endif /* PBWSF__SEAM, PBWIM__SEAM */
#endif /* PBW_MESH3_IMPLEMENTATION */
