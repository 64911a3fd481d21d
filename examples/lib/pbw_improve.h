/* pbw_improve.h - v0.2.0 - makes the worst tetrahedra of a mesh better - MIT-0

   QUICK START
   In one source file, define PBW_IMPROVE_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file, and the implementation of pbw_surface.h in the same
   source file, before it.

       pbw_tets mesh = {0}, better = {0};
       pbw_improve_report report;
       mesh.points = points;    mesh.point_count = n;                // of any mesher
       mesh.corners = corners;  mesh.tet_count = m;
       pbw_improve(&mesh, NULL, NULL, &better, &report);             // dihedral angles of 30 to 150 degrees
       printf("%g..%g\n", report.after.least, report.after.largest);
       pbw_tets_free(&better);

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>measures     measures of tetrahedra and of meshes
     >>mesh         the mesh that changes: points, slots of tetrahedra, edges to keep
     >>change       old tetrahedra replaced by new ones; stars, rings, boundary edges
     >>flips        operations of every pass: edge removal, smoothing, peeling, 2-3 flips
     >>insertion    operations of thorough passes: contraction, rejoining, insertion
     >>load         the input: neighbours, orientation, boundary, features
     >>smoothers    rounds that move all points
     >>passes       blocks of the mesh on all threads, in each the worst tetrahedra first
     >>sizes        edges halved and contracted until they have their lengths
     >>result       the mesh written to the caller's arrays
     >>stages       all of it in order
     >>seam         private names that pbw_mesh3.h and pbw_adapt3.h use

   FUNCTIONS
     pbw_improve       makes the worst tetrahedra better
     pbw_tet_measure   a measure of quality of one tetrahedron
     pbw_measure_name  its name
     pbw_tets_quality  the dihedral angles of a mesh
     pbw_tets_spread   the range and mean of a measure in a mesh
     pbw_tets_free     frees tetrahedra

   HOW
   The quality of a tetrahedron is the least sine of its six dihedral angles: 0 if it is flat, sin 70.5 at best.
   Passes take the tetrahedra below the target, worst first, and try in turn
       edge removal    the tetrahedra around an edge are replaced by those over the best triangulation of the ring of
                       its other corners (Klincsek 1980), inside and on smooth parts of the boundary; 3-2, 4-4 and
                       2-2 flips are the small cases
       smoothing       a corner moves to where its worst tetrahedron is best; on the boundary it slides on the surface
       peeling         a flat tetrahedron at the boundary is taken off
       2-3 flips       a facet is replaced by an edge
       contraction     one end of an edge moves into the other
       rejoining       a corner's star grows over the tetrahedra around it, and its facets are joined to that corner
       insertion       an edge or a tetrahedron gets a corner in its middle, joined to a cavity that grows likewise
   An operation is carried out only if it raises the least quality of the tetrahedra that it changes (Klingner and
   Shewchuk 2007, "Aggressive tetrahedral mesh improvement").  Threads work at once in parts of the mesh, which depend
   on the mesh only.  If tetrahedra below the target are left when the passes end, up to 16 final passes work around
   these only, with a higher target for the neighbours, smaller gains and larger turns of the boundary.
   Two steps come first if the options ask for them:
   1. options.sizes gives edge lengths.  Edges shorter than half of theirs are contracted, and edges longer than 1.4
      times theirs are halved, the worst first, with passes between.
   2. options.rounds move all points that are not fixed, to raise the mean quality: by optimal Delaunay triangulation
      (ODT; Alliez, Cohen-Steiner, Yvinec, Desbrun 2005), by Lloyd's method, or to the mean of the neighbours
      (Laplacian).  Points of one colour have no common tetrahedron and move at once, on all threads.

   PROMISES  (tests/test_improve.c guards them)
     monotone    the least quality never falls below both its old value and the target, up to rounding: when its
                 budget ends, a mesh is not worse than before, unless sizes change it
     positive    every tetrahedron made is positively oriented, by exact signs
     kept        fixed points, feature edges, the edges given, regions and their interfaces, patches and their
                 borders; the boundary is as manifold as it was, has the same Euler number, and stays on the
                 surface: its facets turn from the surface's normals by less than 25 degrees, in final passes by
                 less than 40; facets of the boundary, of interfaces and of patches between frozen points stay as
                 they are, bit for bit
     same        the same bytes for the same input, whatever options.threads says (and unless a budget in seconds ends
                 it)

   CONFIGURATION MACROS
     PBW_IMPROVE_IMPLEMENTATION  in one source file: compile the implementation there
*/
#ifndef PBW_IMPROVE_H
#define PBW_IMPROVE_H
#ifndef PBW_SURFACE_H
#include "pbw_surface.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */
#define PBW_TETS_FOUND  0u                 /* marks of points: fixed on features, else as they lie */
#define PBW_TETS_SLIDES 1u                 /* on the boundary: stays on the surface */
#define PBW_TETS_FIXED  2u
#define PBW_TETS_FROZEN 3u                 /* fixed; facets of the boundary, of interfaces and of patches between
                                              frozen points stay, and so do edges to keep: none is divided */

typedef struct pbw_tets {                  /* in: the caller's arrays; out: start from {0}, pbw_tets_free when done */
    size_t point_count, tet_count;
    const double *points;                  /* 3 coordinates each */
    const pbw_index *corners;              /* 4 points a tetrahedron; out: positively oriented, in: any way */
    const pbw_index *regions;              /* one a tetrahedron, any numbers; NULL = one region */
    const unsigned char *marks;            /* PBW_TETS_*, one a point; NULL = all found.  Out: what they were */
    const pbw_index *neighbors;            /* out: as in pbw_mesh; in: not read */
    const pbw_index *original;             /* out: per point its number in the input, PBW_NONE if it is new */
    const pbw_index *patches;              /* one a corner: of the facet across from it, any number, PBW_NONE = none.
                                              Edges where two of them meet are features.  Inside the facets stay as
                                              they are; in: one of their sides will do.  NULL = none */
    const pbw_index *edges;                /* 2 points each: edges that stay; with sizes they may get points.  In:
                                              pairs that are no edge of the mesh are ignored */
    const pbw_index *edge_origins;         /* out: per edge, the number of the input's edge that has it */
    size_t edge_count;
    void *memory;                          /* private */
} pbw_tets;

/* Measures, after their names in Gmsh and in Verdict (Stimpson et al. 2007, "The Verdict geometric quality library").
   Volumes of negative tetrahedra, and gamma, eta, SICN with them, are negative. */
typedef enum pbw_measure {
    PBW_MEASURE_LEAST_DIHEDRAL,            /* degrees; of the regular tetrahedron 70.53 */
    PBW_MEASURE_LARGEST_DIHEDRAL,
    PBW_MEASURE_LEAST_SINE,                /* of the dihedral angles: what pbw_improve raises */
    PBW_MEASURE_VOLUME,
    PBW_MEASURE_GAMMA,                     /* Gmsh: 3 times inscribed by circumscribed radius, 1 at best */
    PBW_MEASURE_ETA,                       /* Gmsh: 12 (3 V)^(2/3) by sum of squared edges; Verdict: shape */
    PBW_MEASURE_SICN,                      /* Gmsh: 3 / (|S| |1/S|), S the map from the regular one; 1 at best */
    PBW_MEASURE_RADIUS_EDGE,               /* circumscribed radius by shortest edge, 0.612 at best */
    PBW_MEASURE_RADIUS_RATIO,              /* Verdict: 1 / gamma */
    PBW_MEASURE_ASPECT_RATIO,              /* Verdict: longest edge / (2 sqrt 6 inscribed radius), 1 at best */
    PBW_MEASURE_ASPECT_GAMMA,              /* Verdict: root mean square edge^3 sqrt 2 / (12 V), 1 at best */
    PBW_MEASURE_EDGE_RATIO,                /* longest by shortest edge */
    PBW_MEASURE_SCALED_JACOBIAN,           /* Verdict: sqrt 2 times 6 V / largest product of 3 edges at a corner */
    PBW_MEASURE_CONDITION,                 /* Verdict: 1 / SICN, 1 at best */
    PBW_MEASURES                           /* how many there are */
} pbw_measure;

typedef struct pbw_spread {            /* of a measure over a mesh */
    double least, permille, percent, mean; /* the least value, those that 0.1 % and 1 % are below */
    double most;
} pbw_spread;

typedef struct pbw_quality {               /* dihedral angles of a mesh, in degrees */
    double least, permille, percent;       /* of the tetrahedra's least angles the 1st, and those that 0.1 % and 1 %
                                              are below */
    double largest;
    size_t below[4];                       /* tetrahedra with an angle below 5, 10, 20, 30 */
    size_t bins[18];                       /* how many angles, six a tetrahedron, are in each 10 degrees */
    double volume;
    double least_sine;
} pbw_quality;

/* Where a smoother moves a point.  On the boundary the same holds of its triangles there, and then it slides. */
typedef enum pbw_smoother {
    PBW_SMOOTHER_ODT,                      /* to the circumcentres' mean, weighted by volume */
    PBW_SMOOTHER_LLOYD,                    /* to the centroid of its Voronoi cell */
    PBW_SMOOTHER_LAPLACIAN                 /* to the mean of its neighbours */
} pbw_smoother;

typedef struct pbw_improve_options {       /* NULL or all zero = best defaults */
    double target;                         /* degrees, 1 to 60: dihedral angles from this to 180 - this; 0 = 30 */
    double seconds;                        /* of all threads' processor time, then it ends with what it has;
                                              0 = no limit */
    int passes;                            /* at most; 0 = 60, then up to 16 final ones; -1 = none */
    double feature_angle;                  /* degrees: boundary edges whose normals differ by more are kept; 0 = 40 */
    /* Moves a point to the boundary's surface.  Several threads call it at once, also with rounds = 0, unless
       options.threads is 1.  NULL = to the nearest point of the input's boundary. */
    void (*project)(void *user, double point[3]);
    void *project_user;
    double distance;                       /* of boundary facets from the surface, at their middles and those of their
                                              edges, at most; where they are farther, they come no farther; 0 = any */
    const double *sizes;                   /* per point of the input, how long edges shall be there; NULL = as they
                                              are.  Features get points, and lose none */
    int rounds;                            /* of the smoother before the passes, at most */
    pbw_smoother smoother;
} pbw_improve_options;

typedef struct pbw_improve_report {
    pbw_quality before, after;
    size_t turned;                         /* tetrahedra of the input that were negative */
    size_t removals, boundary_removals, smoothings, slides, peelings, flips, contractions, insertions;
    size_t splits;                         /* of edges, for sizes */
    size_t moves;                          /* of the smoother */
    size_t left;                           /* tetrahedra below the target in the end */
    int passes, rounds;
} pbw_improve_report;

/* Improves a mesh; how, options and report may be NULL.  better: overwritten, left empty on failure.  Of options, it
   uses threads, run, resize, memory_limit, progress (PBW_STAGE_WORK) and message.  Returns PBW_ERROR_ARGUMENT for a
   target or smoother out of range, sizes that are not above 0, ids out of range, a tetrahedron with a corner twice,
   more than two tetrahedra at a facet, or two on one side of it: options.message says which size, id or facet. */
PBWDEF pbw_status pbw_improve(const pbw_tets *mesh, const pbw_improve_options *how,
                              const pbw_options *options, pbw_tets *better, pbw_improve_report *report);
/* Returns the measure of the tetrahedron a b c d. */
PBWDEF double pbw_tet_measure(pbw_measure measure, const double a[3], const double b[3], const double c[3],
                              const double d[3]);
PBWDEF const char *pbw_measure_name(pbw_measure measure);     /* "gamma", NULL for other numbers */
/* Returns 0 if there is no memory to sort the angles: permille and percent are then 0. */
PBWDEF int pbw_tets_quality(const pbw_tets *mesh, const pbw_options *options, pbw_quality *quality);
/* Returns 0 and zeroes if there is no memory to sort the values. */
PBWDEF int pbw_tets_spread(const pbw_tets *mesh, pbw_measure measure, const pbw_options *options, pbw_spread *spread);
PBWDEF void pbw_tets_free(pbw_tets *mesh);            /* fine on {0}, fine twice; for results only */

#ifdef __cplusplus
}
#endif
#endif /* PBW_IMPROVE_H */

#if defined(PBW_IMPROVE_IMPLEMENTATION) && !defined(PBWIMPROVE__IMPLEMENTED)
#define PBWIMPROVE__IMPLEMENTED
#if PBWSF__SEAM != 1
#error "pbw_improve.h is compiled where pbw_surface.h of its version is: define PBW_SURFACE_IMPLEMENTATION, too"
#else

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

PBW_CONTRACTION_OFF                        /* fused operations would give other coordinates */

/* ------------------------------------------------------------------------------------------------------
   >>measures     Measures of tetrahedra and of meshes.
   In: points and corners.  Out: a number; angles and quality of a mesh, by blocks on all threads.
   ------------------------------------------------------------------------------------------------------ */

/* Corner i's opposite facet, turned so that corner i is on its positive side. */
static const int pbwim__opposite[4][3] = { { 1, 3, 2 }, { 0, 2, 3 }, { 0, 3, 1 }, { 0, 1, 2 } };
/* The corners of each edge, and the other two, so that the four are an even permutation. */
static const int pbwim__edge[6][4] = { { 0, 1, 2, 3 }, { 0, 2, 3, 1 }, { 0, 3, 1, 2 },
                                       { 1, 2, 0, 3 }, { 1, 3, 2, 0 }, { 2, 3, 0, 1 } };

typedef struct pbwim__shape {              /* of a tetrahedron */
    double volume6;                        /* six times the volume, signed */
    double normal[4][3];                   /* of facet i, inward if positive, twice the area long */
    double square[6];                      /* squared lengths of the edges */
} pbwim__shape;

static void pbwim__shape_of(const double *const c[4], pbwim__shape *s)
{
    double u[3];
    int i;
    for (i = 0; i < 4; i++) {
        pbwsf__normal(c[pbwim__opposite[i][0]], c[pbwim__opposite[i][1]], c[pbwim__opposite[i][2]], s->normal[i]);
    }
    for (i = 0; i < 6; i++) {
        pbwsf__minus(c[pbwim__edge[i][1]], c[pbwim__edge[i][0]], u);
        s->square[i] = pbwsf__dot(u, u);
    }
    pbwsf__minus(c[3], c[0], u);
    s->volume6 = pbwsf__dot(s->normal[3], u);
}

/* The least sine of the dihedral angles, negative for negative tetrahedra.  At an edge of length l between facets of
   areas A and B it is 3 V l / (2 A B). */
static double pbwim__sine(const double *a, const double *b, const double *c, const double *d)
{
    const double x[3] = { b[0] - a[0], b[1] - a[1], b[2] - a[2] }, y[3] = { c[0] - a[0], c[1] - a[1], c[2] - a[2] };
    const double z[3] = { d[0] - a[0], d[1] - a[1], d[2] - a[2] };
    const double bc[3] = { c[0] - b[0], c[1] - b[1], c[2] - b[2] }, bd[3] = { d[0] - b[0], d[1] - b[1], d[2] - b[2] };
    const double cd[3] = { d[0] - c[0], d[1] - c[1], d[2] - c[2] };
    double abc[3], abd[3], acd[3], bcd[3], p, q, r, s, v, least, t;
    int k;
    pbwsf__cross(x, y, abc);
    pbwsf__cross(z, x, abd);
    pbwsf__cross(y, z, acd);
    for (k = 0; k < 3; k++) {
        bcd[k] = abc[k] + abd[k] + acd[k];
    }
    v = pbwsf__dot(abc, z);
    p = pbwsf__dot(abc, abc), q = pbwsf__dot(abd, abd), r = pbwsf__dot(acd, acd), s = pbwsf__dot(bcd, bcd);
    if (!(p > 0 && q > 0 && r > 0 && s > 0)) {
        return 0;
    }
    p = 1 / p, q = 1 / q, r = 1 / r, s = 1 / s;
    least = pbwsf__dot(x, x) * p * q;
    t = pbwsf__dot(y, y) * p * r, least = t < least ? t : least;
    t = pbwsf__dot(z, z) * q * r, least = t < least ? t : least;
    t = pbwsf__dot(bc, bc) * p * s, least = t < least ? t : least;
    t = pbwsf__dot(bd, bd) * q * s, least = t < least ? t : least;
    t = pbwsf__dot(cd, cd) * r * s, least = t < least ? t : least;
    return v * sqrt(least);
}

/* In degrees, from 0 to 180; those of flat tetrahedra are 0 and 180. */
static void pbwim__angles(const double *const c[4], double angle[6])
{
    pbwim__shape s;
    int i;
    pbwim__shape_of(c, &s);
    for (i = 0; i < 6; i++) {
        const double *m = s.normal[pbwim__edge[i][2]], *n = s.normal[pbwim__edge[i][3]];
        angle[i] = 180 - 57.295779513082321 * atan2(fabs(s.volume6) * sqrt(s.square[i]), pbwsf__dot(m, n));
    }
}

/* Returns |S| |1/S| for the map S from the regular tetrahedron.  |S|^2 is half the sum of squared edges; |1/S|^2
   follows from the normals in the same way. */
static double pbwim__condition(const pbwim__shape *s, double squares)
{
    double sum = 0;
    int i;
    for (i = 0; i < 4; i++) {
        sum += pbwsf__dot(s->normal[i], s->normal[i]);
    }
    return sqrt(squares / 2) * sqrt(sum / 2) / s->volume6;
}

static double pbwim__circumradius(const double *const c[4], const pbwim__shape *s)
{
    double sum[3] = { 0, 0, 0 };
    int i, k;
    (void)c;
    for (i = 0; i < 3; i++) {                        /* edges 0, 1, 2 are at corner 0; normals 1, 2, 3 across */
        for (k = 0; k < 3; k++) {
            sum[k] += s->square[i] * s->normal[i + 1][k];
        }
    }
    return sqrt(pbwsf__dot(sum, sum)) / (2 * fabs(s->volume6));
}

PBWDEF double pbw_tet_measure(pbw_measure measure, const double a[3], const double b[3], const double c[3],
                              const double d[3])
{
    const double *const corner[4] = { a, b, c, d };
    double angle[6], least, most, squares = 0, area2 = 0, product = 0, radius, third;
    pbwim__shape s;
    int i;
    pbwim__shape_of(corner, &s);
    if (measure == PBW_MEASURE_LEAST_DIHEDRAL || measure == PBW_MEASURE_LARGEST_DIHEDRAL) {
        pbwim__angles(corner, angle);
        for (i = 1, least = most = angle[0]; i < 6; i++) {
            least = fmin(least, angle[i]);
            most = fmax(most, angle[i]);
        }
        return measure == PBW_MEASURE_LEAST_DIHEDRAL ? least : most;
    }
    for (i = 0, least = most = s.square[0]; i < 6; i++) {
        least = fmin(least, s.square[i]);
        most = fmax(most, s.square[i]);
        squares += s.square[i];
    }
    for (i = 0; i < 4; i++) {                        /* edges at corner i: those across from facet i's */
        static const int at[4][3] = { { 0, 1, 2 }, { 0, 3, 4 }, { 1, 3, 5 }, { 2, 4, 5 } };
        area2 += sqrt(pbwsf__dot(s.normal[i], s.normal[i]));
        product = fmax(product, s.square[at[i][0]] * s.square[at[i][1]] * s.square[at[i][2]]);
    }
    radius = s.volume6 / area2;                      /* inscribed: 3 V / sum of areas */
    third = cbrt(s.volume6 / 2);                     /* 3 V */
    switch (measure) {
    case PBW_MEASURE_LEAST_SINE: return pbwim__sine(a, b, c, d);
    case PBW_MEASURE_VOLUME: return s.volume6 / 6;
    case PBW_MEASURE_GAMMA: return 3 * radius / pbwim__circumradius(corner, &s);
    case PBW_MEASURE_ETA: return 12 * third * fabs(third) / squares;
    case PBW_MEASURE_SICN: return 3 / pbwim__condition(&s, squares);
    case PBW_MEASURE_RADIUS_EDGE: return pbwim__circumradius(corner, &s) / sqrt(least);
    case PBW_MEASURE_RADIUS_RATIO: return pbwim__circumradius(corner, &s) / (3 * radius);
    case PBW_MEASURE_ASPECT_RATIO: return sqrt(most) / (2 * sqrt(6.0) * radius);
    case PBW_MEASURE_ASPECT_GAMMA: return pow(squares / 6, 1.5) * sqrt(2.0) / (2 * s.volume6);
    case PBW_MEASURE_EDGE_RATIO: return sqrt(most / least);
    case PBW_MEASURE_CONDITION: return pbwim__condition(&s, squares) / 3;
    case PBW_MEASURE_SCALED_JACOBIAN: return sqrt(2.0) * s.volume6 / fmax(sqrt(product), s.volume6);
    default: return 0;
    }
}

PBWDEF const char *pbw_measure_name(pbw_measure measure)
{
    static const char *const names[] = { "least dihedral", "largest dihedral", "least sine", "volume", "gamma", "eta",
        "SICN", "radius-edge", "radius ratio", "aspect ratio", "aspect gamma", "edge ratio", "scaled Jacobian",
        "condition" };
    return (unsigned)measure < sizeof names / sizeof *names ? names[measure] : NULL;
}

static int pbwim__compare(const void *a, const void *b)                      /* what is no number comes last */
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y || x > y ? (x > y) - (x < y) : !(x <= HUGE_VAL) - !(y <= HUGE_VAL);
}

PBWDEF int pbw_tets_spread(const pbw_tets *mesh, pbw_measure measure, const pbw_options *options, pbw_spread *spread)
{
    pbw_memory memory;
    pbwsf__numbers sorted = { NULL, 0, 0 };
    const size_t count = mesh->tet_count;
    double *value;
    size_t i;
    pbw_memory_start(&memory, options);
    memset(spread, 0, sizeof *spread);
    if (!PBW_FIT(&memory, sorted, count + 1)) {
        return 0;
    }
    value = sorted.at;
    for (i = 0; i < count; i++) {
        const pbw_index *c = mesh->corners + 4 * i;
        value[i] = pbw_tet_measure(measure, mesh->points + 3 * (size_t)c[0], mesh->points + 3 * (size_t)c[1],
                                   mesh->points + 3 * (size_t)c[2], mesh->points + 3 * (size_t)c[3]);
    }
    if (count > 0) {
        qsort(value, count, sizeof *value, pbwim__compare);
        for (i = 0; i < count; i++) {
            spread->mean += value[i] / (double)count;
        }
        spread->least = value[0];
        spread->permille = value[count / 1000];
        spread->percent = value[count / 100];
        spread->most = value[count - 1];
    }
    PBW_RELEASE(&memory, sorted);
    return 1;
}

/* Puts the value at `rank` that sorting would put there; none larger comes before it, none smaller after it. */
static void pbwim__select(double *value, size_t count, size_t rank)
{
    size_t low = 0, high = count - 1;
    while (low < high) {
        const double pivot = value[low + (high - low) / 2];
        size_t i = low, k = high;
        for (;;) {
            double swap;
            for (; value[i] < pivot; i++) {
            }
            for (; value[k] > pivot; k--) {
            }
            if (i >= k) {
                break;
            }
            swap = value[i];
            value[i++] = value[k];
            value[k--] = swap;
        }
        if (rank <= k) {                             /* value[low..k] <= pivot <= value[k + 1..high] */
            high = k;
        } else {
            low = k + 1;
        }
    }
}

/* Blocks of tetrahedra are measured at once, and summed up in order: sums do not depend on threads. */
enum { PBWIM__BLOCK = 2048 };

/* An angle grows with a ratio, that of the cosine of 180 degrees less the angle to its sine: ratios are compared, and
   only those that are reported become angles. */
typedef struct pbwim__measured {           /* of a block */
    pbw_quality q;
    double least, largest;                 /* ratios */
    size_t tens[18];                       /* tetrahedra by least angles; [0]: then, where those below `limit` go */
} pbwim__measured;

typedef struct pbwim__measuring {
    const pbw_tets *mesh;
    double *least;                         /* ratios, one a tetrahedron, or NULL */
    pbwim__measured *block;
    double *low;                           /* the least ratios below `limit`, block by block */
    double limit;
} pbwim__measuring;

/* Bounds of 10 degrees each, as ratios, the first and last ones included. */
static const double pbwim__tens[21] = { -HUGE_VAL, -5.671281819617709, -2.747477419454622, -1.7320508075688772,
    -1.19175359259421, -0.8390996311772799, -0.5773502691896258, -0.3639702342662024, -0.17632698070846498, 0.0,
    0.17632698070846498, 0.3639702342662024, 0.5773502691896258, 0.8390996311772799, 1.19175359259421,
    1.7320508075688772, 2.747477419454622, 5.671281819617709, HUGE_VAL, HUGE_VAL, HUGE_VAL };

static double pbwim__angle_of(double ratio)
{
    return 180 - 57.295779513082321 * atan2(1, ratio);
}

/* Returns which 10 degrees a ratio is in. */
static int pbwim__bin_of(double ratio)
{
    const double *bound = pbwim__tens + 1;
    const int coarse = 4 * ((ratio >= bound[3]) + (ratio >= bound[7]) + (ratio >= bound[11]) + (ratio >= bound[15]));
    return coarse + (ratio >= bound[coarse]) + (ratio >= bound[coarse + 1]) + (ratio >= bound[coarse + 2]);
}

/* Adds the dihedral angles of a tetrahedron.  Returns the least ratio. */
static double pbwim__measure_angles(const pbwim__shape *s, pbwim__measured *of)
{
    double least = HUGE_VAL, largest = -HUGE_VAL;
    int i;
    for (i = 0; i < 6; i++) {
        const double y = fabs(s->volume6) * sqrt(s->square[i]);
        const double x = pbwsf__dot(s->normal[pbwim__edge[i][2]], s->normal[pbwim__edge[i][3]]);
        const double ratio = y > 0 ? x / y : x < 0 ? -HUGE_VAL : HUGE_VAL;
        const int bin = ratio < HUGE_VAL ? pbwim__bin_of(ratio) : 17;
        least = ratio < least ? ratio : least;
        largest = ratio > largest ? ratio : largest;
        of->q.bins[bin]++;
    }
    of->largest = largest > of->largest ? largest : of->largest;
    return least;
}

static void pbwim__measure_block(const pbwim__measuring *work, size_t block, pbwim__measured *of)
{
    static const double limits[4] = { -11.430052302761343, -5.671281819617709, -2.747477419454622,
                                      -1.7320508075688772 };         /* ratios of 5, 10, 20, 30 degrees */
    const pbw_tets *mesh = work->mesh;
    const size_t end = mesh->tet_count - block * PBWIM__BLOCK < PBWIM__BLOCK ? mesh->tet_count
                                                                             : (block + 1) * PBWIM__BLOCK;
    pbw_quality *q = &of->q;
    size_t i, k;
    memset(of, 0, sizeof *of);
    of->least = HUGE_VAL;
    of->largest = -HUGE_VAL;
    q->least_sine = 1;
    for (i = block * PBWIM__BLOCK; i < end; i++) {
        const double *c[4];
        pbwim__shape s;
        double lowest;
        for (k = 0; k < 4; k++) {
            c[k] = mesh->points + 3 * (size_t)mesh->corners[4 * i + k];
        }
        pbwim__shape_of(c, &s);
        lowest = pbwim__measure_angles(&s, of);
        for (k = 0; k < 4; k++) {
            q->below[k] += lowest < limits[k];
        }
        of->least = lowest < of->least ? lowest : of->least;
        of->tens[lowest < HUGE_VAL ? pbwim__bin_of(lowest) : 17]++;
        q->least_sine = fmin(q->least_sine, pbwim__sine(c[0], c[1], c[2], c[3]));
        q->volume += s.volume6 / 6;
        if (work->least != NULL) {
            work->least[i] = lowest;
        }
    }
    q->least = pbwim__angle_of(of->least);
    q->largest = pbwim__angle_of(of->largest);
}

static pbw_status pbwim__list_low(void *arg, size_t from, size_t to)
{
    const pbwim__measuring *work = (const pbwim__measuring *)arg;
    for (; from < to; from++) {
        const size_t end = work->mesh->tet_count - from * PBWIM__BLOCK < PBWIM__BLOCK ? work->mesh->tet_count
                                                                                      : (from + 1) * PBWIM__BLOCK;
        size_t at = *work->block[from].tens, i;
        for (i = from * PBWIM__BLOCK; i < end; i++) {
            if (work->least[i] < work->limit || work->limit == HUGE_VAL) {
                work->low[at++] = work->least[i];
            }
        }
    }
    return PBW_OK;
}

static pbw_status pbwim__measure_range(void *arg, size_t from, size_t to)
{
    const pbwim__measuring *work = (const pbwim__measuring *)arg;
    for (; from < to; from++) {
        pbwim__measure_block(work, from, work->block + from);
    }
    return PBW_OK;
}

static void pbwim__add_quality(pbw_quality *sum, const pbw_quality *q)
{
    size_t k;
    sum->least = fmin(sum->least, q->least);
    sum->least_sine = fmin(sum->least_sine, q->least_sine);
    sum->largest = fmax(sum->largest, q->largest);
    sum->volume += q->volume;
    for (k = 0; k < 4; k++) {
        sum->below[k] += q->below[k];
    }
    for (k = 0; k < 18; k++) {
        sum->bins[k] += q->bins[k];
    }
}

/* Returns the options for a call of the library: their memory limit is the caller's less the bytes held. */
static pbw_options pbwim__asking_options(const pbw_options *options, const pbw_memory *memory)
{
    pbw_options inner;
    memset(&inner, 0, sizeof inner);
    if (options != NULL) {
        inner = *options;
        inner.memory_limit = pbw_memory_left(memory);
    }
    return inner;
}

/* Returns the same without progress. */
static pbw_options pbwim__inner_options(const pbw_options *options, const pbw_memory *memory)
{
    pbw_options inner = pbwim__asking_options(options, memory);
    inner.progress = NULL;
    return inner;
}

/* Finds the angles that 0.1 % and 1 % of the least angles are below.  It selects among those below the first bound of
   10 degrees that more than 1 % are below.  Returns 0 if there is no memory. */
static int pbwim__find_shares(pbwim__measuring *work, const pbw_options *options, pbw_memory *memory, size_t blocks,
                              pbw_quality *quality)
{
    const size_t count = work->mesh->tet_count;
    pbwsf__numbers low = { NULL, 0, 0 };
    pbw_options inner;
    size_t sum = 0, i, k, tens;
    int done;
    for (tens = 0; tens < 18 && sum <= count / 100; tens++) {
        for (i = 0; i < blocks; i++) {
            sum += work->block[i].tens[tens];
        }
    }
    if (!PBW_FIT(memory, low, sum)) {
        return 0;
    }
    for (i = sum = 0; i < blocks; i++) {
        size_t here = 0;
        for (k = 0; k < tens; k++) {
            here += work->block[i].tens[k];
        }
        *work->block[i].tens = sum;
        sum += here;
    }
    work->limit = pbwim__tens[tens];
    work->low = low.at;
    inner = pbwim__inner_options(options, memory);
    done = pbw_for(&inner, blocks, 16, pbwim__list_low, work) == PBW_OK;
    if (done) {
        pbwim__select(low.at, sum, count / 100);
        quality->percent = pbwim__angle_of(low.at[count / 100]);
        pbwim__select(low.at, count / 100 + 1, count / 1000);
        quality->permille = pbwim__angle_of(low.at[count / 1000]);
    }
    PBW_RELEASE(memory, low);
    return done;
}

/* Returns 0 if there is no memory for the shares, or options.progress cancels: nothing is measured then. */
static int pbwim__measure(const pbw_tets *mesh, const pbw_options *options, pbw_quality *quality)
{
    const size_t count = mesh->tet_count, blocks = count / PBWIM__BLOCK + (count % PBWIM__BLOCK != 0);
    pbw_memory memory;
    pbwsf__numbers least = { NULL, 0, 0 };
    PBW_ARRAY(pbwim__measured) block = { NULL, 0, 0 };
    pbwim__measuring work;
    pbw_options inner;
    pbw_status status;
    size_t i;
    int kept, done;
    pbw_memory_start(&memory, options);
    memset(quality, 0, sizeof *quality);
    kept = PBW_FIT(&memory, least, count + 1) && PBW_FIT(&memory, block, blocks + 1);
    quality->least = count > 0 ? 180 : 0;
    quality->least_sine = count > 0 ? 1 : 0;
    memset(&work, 0, sizeof work);
    work.mesh = mesh;
    work.block = block.at;
    work.least = kept ? least.at : NULL;
    inner = pbwim__asking_options(options, &memory);
    status = kept ? pbw_for(&inner, blocks, 1, pbwim__measure_range, &work) : PBW_ERROR_MEMORY;
    done = status == PBW_OK;
    for (i = 0; i < blocks && status != PBW_CANCELLED; i++) {
        pbwim__measured here;
        if (!done) {
            pbwim__measure_block(&work, i, &here);
        }
        pbwim__add_quality(quality, done ? &work.block[i].q : &here.q);
    }
    if (done && count > 0) {
        kept = pbwim__find_shares(&work, options, &memory, blocks, quality);
    }
    PBW_RELEASE(&memory, least);
    PBW_RELEASE(&memory, block);
    return kept && done;
}

PBWDEF int pbw_tets_quality(const pbw_tets *mesh, const pbw_options *options, pbw_quality *quality)
{
    pbw_options plain;
    if (options != NULL) {
        plain = *options;
        plain.progress = NULL;
    }
    return pbwim__measure(mesh, options != NULL ? &plain : NULL, quality);
}

/* ------------------------------------------------------------------------------------------------------
   >>mesh         The mesh that changes: points, slots of tetrahedra, edges to keep.
   Holds: tetrahedra are positive but for flat ones of the input;
   next[4 t + i] is the tetrahedron across from corner i, PBW_NONE on the boundary; star[p] is one of p's tetrahedra,
   PBW_NONE if it has none; quality[t] is the least sine of t; a free slot has corner[4 t] = PBW_NONE and next[4 t] =
   the free slot after it.
   ------------------------------------------------------------------------------------------------------ */
enum {
    PBWIM__MOST = 192,                     /* tetrahedra that one operation replaces; larger stars are left alone */
    PBWIM__ZONE = 512,                     /* tetrahedra that improving one may read beside threads; a power of 2 */
    PBWIM__ZONE_SHIFT = 22,                /* makes of a hash of 32 bits an index of a table of 2 ZONE */
    PBWIM__RING = 10,                      /* corners of a ring */
    PBWIM__SLICE = 4096,                   /* tetrahedra or points of one range of a loop on all threads */
    PBWIM__OPEN = 8 * PBWIM__MOST,          /* facets of that, at most */
    PBWIM__SPARE = 2 * PBWIM__RING,        /* free slots of a task: no operation of a pass makes more tetrahedra */
    PBWIM__PROJECTION = 16                 /* sines that take as long as a projection, about */
};
#define PBWIM__PASSES 60
#define PBWIM__GAIN 1e-3                   /* least gain of the least sine for an operation */
#define PBWIM__SMOOTH_GAIN 0.1             /* least gain of smoothing, as a share of the way to the target */
#define PBWIM__FINAL_GAIN 0.01             /* the same in final passes */
#define PBWIM__DISTANCE_SHARE 0.6          /* of the distance limit: what boundary facets may use at first */
#define PBWIM__FINAL_RAISE 0.07            /* radians, 4 degrees: final passes raise the target by it, then by 2 x */
#define PBWIM__SMOOTH_COSINE 0.90630778703665          /* cos 25 degrees: boundary facets turn by less */
#define PBWIM__FINAL_COSINE 0.766044443118978          /* cos 40 degrees: the same in final passes */

typedef struct pbwim__kept_edge { pbw_index a, b, origin; } pbwim__kept_edge; /* a < b; origin PBW_NONE: no more */
typedef PBW_ARRAY(pbwim__kept_edge) pbwim__kept_edges;
typedef struct pbwim__item { double quality; pbw_index t, block; } pbwim__item;
typedef PBW_ARRAY(pbwim__item) pbwim__items;

struct pbwim__task;

typedef struct pbwim__mesh {
    pbw_memory memory;
    const pbw_options *options;
    void (*project)(void *user, double point[3]);
    void *project_user;
    double distance;                       /* of boundary facets from the surface, at most */
    double turn;                           /* cosine: boundary facets turn by less */
    double smooth_gain;                    /* least gain of smoothing, as a share of the way to the target */
    int turned;                            /* 1: smoothing climbs in directions turned at random */
    /* per point */
    pbwsf__vectors x;
    pbwsf__indices star, touched, original;
    pbwsf__indices failed;                 /* when smoothing it failed last */
    pbwsf__flags mark;
    pbwsf__numbers size;                   /* only if there are sizes */
    pbwsf__flags joint;                    /* of the input's points: 1 where tetrahedra meet with no facet between */
    /* per tetrahedron */
    pbwsf__quadruples corner, next;
    pbwsf__numbers quality;
    pbwsf__indices region, seen;
    pbwsf__pairs tried;                    /* when: by operations of every pass, by all; see `clock` */
    pbwsf__quadruples patch;               /* of facets; empty if there are none */
    pbwim__kept_edges edge;                /* hash table of the edges to keep, by their ends; count: used entries */
    size_t points, tets;                   /* slots in use, free ones included */
    pbw_index free;                        /* the first free slot */
    size_t spare;                          /* how many there are */
    pbw_index clock, visit;                /* counts changes; counts searches, the value of `seen` in the last one */
    double target;                         /* a sine */
    double cosine;                         /* of the feature angle */
    int sized, patched;
    pbw_improve_report *report;
    double done[2];                        /* of the work, as last reported; when the loop in work has ended */
    int cancelled;                         /* 1: a loop was cancelled */
    double deadline;                       /* the processor time at which it ends with what it has; 0: never */
    size_t effort;                         /* since the task went on: sines computed, about */
    pbwim__items queue, sorted;
    PBW_ARRAY(struct pbwim__task) tasks;
    pbwsf__pairs place;                    /* of points along two curves; empty before the first large pass */
    size_t placed;                         /* how many points there were then: places are below */
    pbwsf__flags active;                   /* per point: passes work where it is not 0; empty: everywhere */
    pbwsf__counts tally;                   /* per slice of the tetrahedra or points */
    pbw_surface surface;                   /* the input's boundary, for project */
    pbwsf__indices facets;
} pbwim__mesh;

static double pbwim__sine_of(const pbwim__mesh *m, const pbw_index c[4])
{
    return pbwim__sine(m->x.at[c[0]], m->x.at[c[1]], m->x.at[c[2]], m->x.at[c[3]]);
}

static int pbwim__sign_of(const pbwim__mesh *m, const pbw_index c[4])
{
    return pbw_orient3(m->x.at[c[0]], m->x.at[c[1]], m->x.at[c[2]], m->x.at[c[3]]);
}

/* Returns the corner of t at which p is; 4 if it is none. */
static int pbwim__corner_of(const pbwim__mesh *m, pbw_index t, pbw_index p)
{
    const pbw_index *c = m->corner.at[t];
    return c[0] == p ? 0 : c[1] == p ? 1 : c[2] == p ? 2 : c[3] == p ? 3 : 4;
}

/* The facet of t through which its neighbour n is. */
static int pbwim__facet_to(const pbwim__mesh *m, pbw_index t, pbw_index n)
{
    const pbw_index *next = m->next.at[t];
    return next[0] == n ? 0 : next[1] == n ? 1 : next[2] == n ? 2 : 3;
}

/* The outward normal of a facet, twice the area long. */
static void pbwim__outward(const pbwim__mesh *m, pbw_index t, int facet, double out[3])
{
    const pbw_index *c = m->corner.at[t];
    const int *o = pbwim__opposite[facet];
    pbwsf__normal(m->x.at[c[o[0]]], m->x.at[c[o[2]]], m->x.at[c[o[1]]], out);
}

/* Returns whether the angle between two directions is below that of the cosine. */
static int pbwim__turned_less(const double a[3], const double b[3], double cosine)
{
    const double dot = pbwsf__dot(a, b), limit = cosine * cosine * pbwsf__dot(a, a) * pbwsf__dot(b, b);
    return cosine > 0 ? dot > 0 && dot * dot > limit : dot > 0 || dot * dot < limit;
}

static int pbwim__resize_points(pbwim__mesh *m, size_t count)
{
    pbw_memory *y = &m->memory;
    return PBW_FIT(y, m->x, count)
        && PBW_FIT(y, m->star, count)
        && PBW_FIT(y, m->touched, count)
        && PBW_FIT(y, m->failed, count)
        && PBW_FIT(y, m->original, count)
        && (m->placed == 0 || PBW_FIT(y, m->place, count))
        && (!m->sized || PBW_FIT(y, m->size, count)) && PBW_FIT(y, m->mark, count);
}

static int pbwim__resize_tets(pbwim__mesh *m, size_t count)
{
    pbw_memory *y = &m->memory;
    return PBW_FIT(y, m->corner, count)
        && PBW_FIT(y, m->next, count)
        && PBW_FIT(y, m->quality, count)
        && PBW_FIT(y, m->region, count)
        && PBW_FIT(y, m->tried, count)
        && (!m->patched || PBW_FIT(y, m->patch, count))
        && PBW_FIT(y, m->tally, count / PBWIM__SLICE + 1)
        && PBW_FIT(y, m->seen, count);
}

/* ---- loops on all threads ---- */

/* Reports that so much of the work is done.  Returns 1 if the caller cancels. */
static int pbwim__progress(pbwim__mesh *m, double done)
{
    m->done[0] = m->done[1] = done;
    return m->options != NULL && m->options->progress != NULL
        && m->options->progress(m->options->progress_user, PBW_STAGE_WORK, done) != 0;
}

/* The progress of a loop, from done[0] to done[1] of the work. */
static int pbwim__pass_on(void *user, pbw_stage stage, double done)
{
    pbwim__mesh *m = (pbwim__mesh *)user;
    (void)stage;
    m->cancelled = m->options->progress(m->options->progress_user, PBW_STAGE_WORK,
                                        m->done[0] + done * (m->done[1] - m->done[0])) != 0;
    return m->cancelled;
}

/* Returns the options for a loop of the call. */
static pbw_options pbwim__loop_options(pbwim__mesh *m)
{
    pbw_options inner = pbwim__asking_options(m->options, &m->memory);
    if (inner.progress != NULL) {
        inner.progress = pbwim__pass_on;
        inner.progress_user = m;
    }
    return inner;
}

/* pbw_for within the call. */
static pbw_status pbwim__for(pbwim__mesh *m, size_t count, size_t grain, pbw_body *body, void *arg)
{
    const pbw_options inner = pbwim__loop_options(m);
    return pbw_for(&inner, count, grain, body, arg);
}

/* Makes of the counts of slices their sums so far.  Returns the sum of all. */
static size_t pbwim__sum_up(size_t *tally, size_t slices)
{
    size_t sum = 0, i;
    for (i = 0; i < slices; i++) {
        const size_t here = tally[i];
        tally[i] = sum;
        sum += here;
    }
    return sum;
}

/* Returns how many slices `count` items make. */
static size_t pbwim__slices(size_t count)
{
    return count / PBWIM__SLICE + (count % PBWIM__SLICE != 0);
}

/* ---- edges to keep ---- */

/* The entry of an edge, or a free one: a = PBW_NONE. */
static pbwim__kept_edge *pbwim__find_edge(const pbwim__mesh *m, pbw_index a, pbw_index b)
{
    pbwim__kept_edge *table = m->edge.at;
    const size_t mask = m->edge.capacity - 1;        /* a power of two */
    const pbw_index low = a < b ? a : b, high = a < b ? b : a;
    size_t at = (size_t)((((uint64_t)low << 32 | high) * 0x9e3779b97f4a7c15u) >> 32) & mask;
    while (table[at].a != PBW_NONE && (table[at].a != low || table[at].b != high)) {
        at = (at + 1) & mask;
    }
    return table + at;
}

static int pbwim__is_kept(const pbwim__mesh *m, pbw_index a, pbw_index b)
{
    const pbwim__kept_edge *e = m->edge.count > 0 ? pbwim__find_edge(m, a, b) : NULL;
    return e != NULL && e->a != PBW_NONE && e->origin != PBW_NONE;
}

/* Notes an edge; there is room. */
static void pbwim__keep_edge(pbwim__mesh *m, pbw_index a, pbw_index b, pbw_index origin)
{
    pbwim__kept_edge *e = pbwim__find_edge(m, a, b);
    m->edge.count += e->a == PBW_NONE;
    e->a = a < b ? a : b;
    e->b = a < b ? b : a;
    e->origin = origin;
}

/* Makes room in the table for `more` edges, so that it stays half empty. */
static int pbwim__reserve_edges(pbwim__mesh *m, size_t more)
{
    pbwim__kept_edges old = m->edge, larger = { NULL, 0, 0 };
    size_t size = 64, i;
    while (size < 2 * (old.count + more)) {
        size *= 2;
    }
    if (size <= old.capacity) {
        return 1;
    }
    if (!PBW_FIT(&m->memory, larger, size)) {
        return 0;
    }
    memset(larger.at, 0xff, size * sizeof *larger.at);           /* all PBW_NONE */
    m->edge = larger;
    for (i = 0; i < old.capacity; i++) {
        if (old.at[i].a != PBW_NONE && old.at[i].origin != PBW_NONE) {
            pbwim__keep_edge(m, old.at[i].a, old.at[i].b, old.at[i].origin);
        }
    }
    PBW_RELEASE(&m->memory, old);
    return 1;
}

/* Makes room for one operation and for so many more tetrahedra and points, so that none of them fails.  Compares with
   the arrays that are resized last: if memory ran out between, these are the shortest. */
static int pbwim__reserve(pbwim__mesh *m, size_t more_tets, size_t more_points)
{
    const size_t tets = m->tets + 2 * PBWIM__MOST + more_tets, points = m->points + 4 + more_points;
    if (tets >= PBW_NONE / 4 || points >= PBW_NONE || (m->edge.count > 0 && !pbwim__reserve_edges(m, 2))) {
        return 0;
    }
    return (m->seen.capacity >= tets || pbwim__resize_tets(m, tets + tets / 4))
        && (m->mark.capacity >= points || pbwim__resize_points(m, points + points / 4));
}

/* A new search: no tetrahedron is seen. */
static void pbwim__visit(pbwim__mesh *m)
{
    if (++m->visit == PBW_NONE) {
        memset(m->seen.at, 0, m->seen.capacity * sizeof *m->seen.at);
        m->visit = 1;
    }
}

static pbw_index pbwim__new_slot(pbwim__mesh *m)
{
    pbw_index t = m->free;
    if (t == PBW_NONE) {
        t = (pbw_index)m->tets++;
    } else {
        m->free = *m->next.at[t];
        m->spare--;
    }
    m->seen.at[t] = 0;
    m->tried.at[t][0] = m->tried.at[t][1] = 0;
    return t;
}

static void pbwim__free_slot(pbwim__mesh *m, pbw_index t)
{
    *m->corner.at[t] = PBW_NONE;
    *m->next.at[t] = m->free;
    m->free = t;
    m->spare++;
}

/* ------------------------------------------------------------------------------------------------------
   >>change       Old tetrahedra replaced by new ones; stars, rings and boundary edges.
   In: a mesh; old tetrahedra, and the corners of new ones in the same space.  Out: the mesh with the new ones.
   Holds: new tetrahedra are positive, by exact signs; regions, patches and edges to keep stay.
   ------------------------------------------------------------------------------------------------------ */

typedef struct pbwim__change {
    int olds, news;
    pbw_index old[PBWIM__MOST], fresh[PBWIM__MOST][4];
    int halves;                            /* 1: fresh tetrahedra 2 i and 2 i + 1 are the halves of the old one i */
} pbwim__change;

typedef struct pbwim__facet { pbw_index v[3], t; int i; } pbwim__facet;
typedef PBW_ARRAY(pbwim__facet) pbwim__facets;

static void pbwim__sort3(pbw_index v[3])
{
    pbw_index x;
    int i;
    for (i = 0; i < 3; i++) {
        const int k = i == 1;
        if (v[k] > v[k + 1]) {
            x = v[k];
            v[k] = v[k + 1];
            v[k + 1] = x;
        }
    }
}

static pbwim__facet pbwim__facet_of(const pbwim__mesh *m, pbw_index t, int i)
{
    pbwim__facet f;
    int k;
    for (k = 0; k < 3; k++) {
        f.v[k] = m->corner.at[t][pbwim__opposite[i][k]];
    }
    pbwim__sort3(f.v);
    f.t = t;
    f.i = i;
    return f;
}

/* Removes the old tetrahedra.  Returns the number of facets of others that this leaves open. */
static int pbwim__remove_tets(pbwim__mesh *m, const pbwim__change *change, pbwim__facet *open)
{
    int count = 0, i, k;
    pbwim__visit(m);
    for (i = 0; i < change->olds; i++) {
        m->seen.at[change->old[i]] = m->visit;
    }
    for (i = 0; i < change->olds; i++) {
        for (k = 0; k < 4; k++) {
            const pbw_index p = m->corner.at[change->old[i]][k];
            m->star.at[p] = PBW_NONE;
            m->touched.at[p] = m->clock;
        }
    }
    for (i = 0; i < change->olds; i++) {
        for (k = 0; k < 4; k++) {
            const pbw_index n = m->next.at[change->old[i]][k];
            if (n != PBW_NONE && m->seen.at[n] != m->visit) {
                open[count] = pbwim__facet_of(m, n, pbwim__facet_to(m, n, change->old[i]));
                m->next.at[n][open[count].i] = PBW_NONE;
                m->star.at[open[count].v[0]] = n;
                m->star.at[open[count].v[1]] = n;
                m->star.at[open[count].v[2]] = n;
                count++;
            }
        }
    }
    return count;
}

/* Lists the boundary facets of the old tetrahedra, with their patches as t.  Returns how many. */
static int pbwim__list_lost(const pbwim__mesh *m, const pbwim__change *change, pbwim__facet *lost)
{
    int count = 0, i, k;
    for (i = 0; i < change->olds && m->patched; i++) {
        for (k = 0; k < 4; k++) {
            if (m->next.at[change->old[i]][k] == PBW_NONE) {
                lost[count] = pbwim__facet_of(m, change->old[i], k);
                lost[count++].t = m->patch.at[change->old[i]][k];
            }
        }
    }
    return count;
}

/* Sets the patches of the new boundary facets: a lost facet with the same corners has the patch; all other lost
   facets are of one patch, which the other new ones get. */
static void pbwim__assign_patches(pbwim__mesh *m, const pbwim__facet *open, int count, pbwim__facet *lost,
                                  int lost_count)
{
    pbw_index rest = PBW_NONE;
    int i, j, pass;
    for (pass = 0; pass < 2; pass++) {
        for (i = 0; i < count; i++) {
            pbw_index *patch = m->patch.at[open[i].t] + open[i].i;
            for (j = 0; j < lost_count && memcmp(open[i].v, lost[j].v, sizeof lost[j].v) != 0; j++) {
            }
            if (j < lost_count) {
                *patch = lost[j].t;
                lost[j].i = -1;
            } else if (pass == 1) {
                *patch = rest;
            }
        }
        for (j = 0; j < lost_count; j++) {
            rest = lost[j].i >= 0 ? lost[j].t : rest;
        }
    }
}

/* Fills the patches of the halves of tetrahedra: those of the facets that are halved, none between two halves. */
static void pbwim__halve_patches(const pbwim__mesh *m, const pbwim__change *change, pbw_index (*half)[4])
{
    int i, k;
    for (i = 0; i < change->news; i++) {
        const pbw_index *whole = m->corner.at[change->old[i / 2]];
        for (k = 0; k < 4; k++) {                    /* the corner that the other half has, and this one has not */
            const int between = change->fresh[i ^ 1][k] != whole[k];
            half[i][k] = between ? PBW_NONE : m->patch.at[change->old[i / 2]][k];
        }
    }
}

/* Applies a change.  Facets without a partner are on the boundary. */
static void pbwim__apply(pbwim__mesh *m, const pbwim__change *change)
{
    pbwim__facet open[PBWIM__OPEN], lost[4 * PBWIM__MOST];
    pbw_index region[PBWIM__MOST], half[2 * PBWIM__RING][4];
    int count, losses, i, k, j;
    for (i = 0; i < change->news; i++) {
        region[i] = m->region.at[change->old[change->halves ? i / 2 : 0]];
    }
    losses = pbwim__list_lost(m, change, lost);
    if (m->patched && change->halves) {
        pbwim__halve_patches(m, change, half);
    }
    m->clock++;
    count = pbwim__remove_tets(m, change, open);
    for (i = 0; i < change->olds; i++) {
        pbwim__free_slot(m, change->old[i]);
    }
    for (i = 0; i < change->news; i++) {
        const pbw_index t = pbwim__new_slot(m);
        memcpy(m->corner.at[t], change->fresh[i], 4 * sizeof(pbw_index));
        m->region.at[t] = region[i];
        m->quality.at[t] = pbwim__sine_of(m, change->fresh[i]);
        for (k = 0; k < 4; k++) {
            const pbwim__facet f = pbwim__facet_of(m, t, k);
            m->star.at[change->fresh[i][k]] = t;
            m->touched.at[change->fresh[i][k]] = m->clock;
            for (j = count - 1; j >= 0 && memcmp(open[j].v, f.v, sizeof f.v) != 0; j--) {
            }
            if (m->patched) {
                m->patch.at[t][k] = j < 0 ? PBW_NONE : m->patch.at[open[j].t][open[j].i];
            }
            if (j < 0) {
                m->next.at[t][k] = PBW_NONE;
                open[count++] = f;
            } else {
                m->next.at[t][k] = open[j].t;
                m->next.at[open[j].t][open[j].i] = t;
                open[j] = open[--count];
            }
        }
        if (m->patched && change->halves) {
            memcpy(m->patch.at[t], half[i], sizeof half[i]);
        }
    }
    if (m->patched && !change->halves) {
        pbwim__assign_patches(m, open, count, lost, losses);
    }
}

/* Returns whether a patch lies between old tetrahedra, or an edge to keep is in none of the new ones. */
static int pbwim__breaks_constraint(const pbwim__mesh *m, const pbwim__change *change)
{
    int i, k, j;
    for (i = 0; i < 4 * change->olds && m->patched; i++) {
        const pbw_index n = m->next.at[change->old[i / 4]][i % 4];
        if (n != PBW_NONE && m->patch.at[change->old[i / 4]][i % 4] != PBW_NONE) {
            for (j = 0; j < change->olds && change->old[j] != n; j++) {
            }
            if (j < change->olds) {
                return 1;
            }
        }
    }
    for (i = 0; i < 6 * change->olds && m->edge.count > 0; i++) {
        const pbw_index *c = m->corner.at[change->old[i / 6]];
        const pbw_index a = c[pbwim__edge[i % 6][0]], b = c[pbwim__edge[i % 6][1]];
        if (m->mark.at[a] < PBW_TETS_FIXED || m->mark.at[b] < PBW_TETS_FIXED || !pbwim__is_kept(m, a, b)) {
            continue;
        }
        for (j = 0; j < change->news; j++) {
            int ends = 0;
            for (k = 0; k < 4; k++) {
                ends += change->fresh[j][k] == a || change->fresh[j][k] == b;
            }
            if (ends == 2) {
                break;
            }
        }
        if (j == change->news) {
            return 1;
        }
    }
    return 0;
}

/* Returns whether all new tetrahedra are positive, by exact signs, and all old ones are of one region, without a
   patch or an edge to keep inside. */
static int pbwim__is_sound(const pbwim__mesh *m, const pbwim__change *change)
{
    int i;
    for (i = 1; i < change->olds && !change->halves; i++) {
        if (m->region.at[change->old[i]] != m->region.at[change->old[0]]) {
            return 0;
        }
    }
    for (i = 0; i < change->news && pbwim__sign_of(m, change->fresh[i]) > 0; i++) {
    }
    return i == change->news && (change->halves || !pbwim__breaks_constraint(m, change));
}

static double pbwim__worst_old(const pbwim__mesh *m, const pbwim__change *change)
{
    double worst = 2;
    int i;
    for (i = 0; i < change->olds; i++) {
        worst = fmin(worst, m->quality.at[change->old[i]]);
    }
    return worst;
}

/* ---- stars, rings and boundary edges ---- */

/* Fills `list` with t and the tetrahedra that are connected to it through facets, all of these with one of the points
   `core`: t has one, too.  Returns how many, 0 if they are more than `most`, which is at most PBWIM__ZONE.  It writes
   nothing to the mesh: threads do this at once. */
static int pbwim__around(const pbwim__mesh *m, pbw_index t, const pbw_index *core, int cores, pbw_index *list,
                         int most)
{
    uint16_t table[2 * PBWIM__ZONE] = { 0 };         /* 1 more than where it is in the list, by a hash; 0 = none */
    int count = 0, i, k, j;
    list[count++] = t;
    table[t * 0x9e3779b1u >> PBWIM__ZONE_SHIFT] = 1;
    for (i = 0; i < count; i++) {
        const pbw_index *c = m->corner.at[list[i]], *next = m->next.at[list[i]];
        int cored = 0;                               /* bit k: corner k is one of the points */
        for (j = 0; j < cores; j++) {
            cored |= (c[0] == core[j]) | (c[1] == core[j]) << 1 | (c[2] == core[j]) << 2 | (c[3] == core[j]) << 3;
        }
        for (k = 0; k < 4; k++) {
            pbw_index n;
            uint32_t at;
            if ((cored & ~(1 << k)) == 0 || next[k] == PBW_NONE) {       /* other links may change */
                continue;
            }
            n = next[k];
            for (at = n * 0x9e3779b1u >> PBWIM__ZONE_SHIFT; table[at] != 0 && list[table[at] - 1] != n;) {
                at = (at + 1) % (2 * PBWIM__ZONE);
            }
            if (table[at] == 0) {
                if (count == most) {
                    return 0;
                }
                list[count++] = n;
                table[at] = (uint16_t)count;
            }
        }
    }
    return count;
}

/* Fills `star` with the tetrahedra at p that are connected through facets.  Returns how many, 0 if too many. */
static int pbwim__star_of(const pbwim__mesh *m, pbw_index p, pbw_index *star)
{
    return m->star.at[p] == PBW_NONE ? 0 : pbwim__around(m, m->star.at[p], &p, 1, star, PBWIM__MOST);
}

typedef struct pbwim__ring {               /* around the edge from a to b, counter-clockwise seen from b */
    pbw_index a, b, tet[PBWIM__RING], corner[PBWIM__RING + 1];
    int tets, corners, closed;             /* open: one corner more than tetrahedra */
} pbwim__ring;

/* The other two corners of t at the edge, so that a, b, *c, *d are positive. */
static void pbwim__other_corners(const pbwim__mesh *m, pbw_index t, const pbwim__ring *ring, int *c, int *d)
{
    static const signed char others[4][4][2] = {
        { { 0, 0 }, { 2, 3 }, { 3, 1 }, { 1, 2 } }, { { 3, 2 }, { 0, 0 }, { 0, 3 }, { 2, 0 } },
        { { 1, 3 }, { 3, 0 }, { 0, 0 }, { 0, 1 } }, { { 2, 1 }, { 0, 2 }, { 1, 0 }, { 0, 0 } }
    };
    const int i = pbwim__corner_of(m, t, ring->a), k = pbwim__corner_of(m, t, ring->b);
    *c = others[i][k][0];
    *d = others[i][k][1];
}

/* Walks around the edge of t; a and b are set.  Returns 0 if too many are there. */
static int pbwim__walk_ring(const pbwim__mesh *m, pbw_index t, pbwim__ring *ring)
{
    pbw_index at = t, first = t;
    int c, d, steps;
    for (steps = 0; steps <= PBWIM__RING; steps++) {         /* back to the boundary, or once around */
        pbwim__other_corners(m, at, ring, &c, &d);
        first = at;
        at = m->next.at[at][d];
        if (at == PBW_NONE || at == t) {
            break;
        }
    }
    ring->closed = at == t;
    first = ring->closed ? t : first;
    ring->tets = ring->corners = 0;
    for (at = first; steps <= PBWIM__RING && ring->tets < PBWIM__RING;) {
        const pbw_index *corner = m->corner.at[at];
        pbwim__other_corners(m, at, ring, &c, &d);
        ring->tet[ring->tets++] = at;
        ring->corner[ring->corners++] = corner[c];
        at = m->next.at[at][c];
        if (at == PBW_NONE) {
            ring->corner[ring->corners++] = corner[d];
        }
        if (at == PBW_NONE || at == first) {
            return 1;
        }
    }
    return 0;
}

/* Returns the largest distance from the surface of a triangle's middle and its edges' middles, or `least`. */
static double pbwim__farthest(const pbwim__mesh *m, const double *a, const double *b, const double *c, double least)
{
    static const double share[4][3] = { { 1.0 / 3, 1.0 / 3, 1.0 / 3 }, { 0.5, 0.5, 0 }, { 0, 0.5, 0.5 },
                                        { 0.5, 0, 0.5 } };
    int i, k;
    for (i = 0; i < 4; i++) {
        double p[3], place[3];
        for (k = 0; k < 3; k++) {
            p[k] = place[k] = share[i][0] * a[k] + share[i][1] * b[k] + share[i][2] * c[k];
        }
        m->project(m->project_user, place);
        least = fmax(least, pbwsf__distance(p, place));
    }
    return least;
}

/* Returns whether the facets at the edge between an open ring's ends would be near the surface. */
static int pbwim__flip_stays_near(const pbwim__mesh *m, const pbwim__ring *ring)
{
    const double *a = m->x.at[ring->a], *b = m->x.at[ring->b], *first = m->x.at[ring->corner[0]];
    const double *last = m->x.at[ring->corner[ring->corners - 1]];
    double after;
    if (!(m->distance > 0)) {
        return 1;
    }
    after = pbwim__farthest(m, a, last, first, pbwim__farthest(m, b, first, last, 0));
    return after <= m->distance || after <= pbwim__farthest(m, a, b, first, pbwim__farthest(m, b, a, last, 0));
}

/* Returns whether patches meet at an edge: those of the boundary's facets there differ, or there is one inside. */
static int pbwim__is_border(const pbwim__mesh *m, const pbwim__ring *ring)
{
    pbw_index patch[2] = { PBW_NONE, PBW_NONE };
    int i, n;
    for (i = 0; i < ring->tets && m->patched; i++) {
        const pbw_index t = ring->tet[i];
        const int next = pbwim__corner_of(m, t, ring->corner[(i + 1) % ring->corners]);
        const int here = pbwim__corner_of(m, t, ring->corner[i]);
        for (n = 0; n < 2; n++) {                    /* the facets before and after it */
            const int k = n == 0 ? next : here;
            if (m->next.at[t][k] == PBW_NONE) {
                patch[n] = m->patch.at[t][k];
            } else if (m->patch.at[t][k] != PBW_NONE) {
                return 1;
            }
        }
    }
    return m->patched && !ring->closed && patch[0] != patch[1];
}

/* Returns whether the facet of t across from corner k is of the boundary, an interface or a patch, and frozen. */
static int pbwim__is_frozen_facet(const pbwim__mesh *m, pbw_index t, int k)
{
    const pbw_index *c = m->corner.at[t], n = m->next.at[t][k];
    const int *o = pbwim__opposite[k];
    return (n == PBW_NONE || m->region.at[n] != m->region.at[t] || (m->patched && m->patch.at[t][k] != PBW_NONE))
        && m->mark.at[c[o[0]]] == PBW_TETS_FROZEN && m->mark.at[c[o[1]]] == PBW_TETS_FROZEN
        && m->mark.at[c[o[2]]] == PBW_TETS_FROZEN;
}

/* Returns whether one of those facets is at the ring's edge, or the edge is to be kept and has frozen ends. */
static int pbwim__is_frozen(const pbwim__mesh *m, const pbwim__ring *ring)
{
    const unsigned char *mark = m->mark.at;
    int i, k;
    for (i = 0; i < ring->tets; i++) {
        const pbw_index *c = m->corner.at[ring->tet[i]];
        for (k = 0; k < 4; k++) {
            if (c[k] != ring->a && c[k] != ring->b && pbwim__is_frozen_facet(m, ring->tet[i], k)) {
                return 1;
            }
        }
    }
    return mark[ring->a] == PBW_TETS_FROZEN && mark[ring->b] == PBW_TETS_FROZEN
        && pbwim__is_kept(m, ring->a, ring->b);
}

/* Returns whether the boundary edge of an open ring may be replaced by the edge between the ring's ends: it lies
   within a smooth part, and the new facets are smooth too. */
static int pbwim__may_flip(pbwim__mesh *m, const pbwim__ring *ring)
{
    const pbw_index a = ring->a, b = ring->b, first = ring->corner[0], last = ring->corner[ring->corners - 1];
    pbw_index star[PBWIM__MOST];
    double n[4][3], sum[3];
    int i, count;
    pbwsf__normal(m->x.at[a], m->x.at[b], m->x.at[first], n[0]);
    pbwsf__normal(m->x.at[b], m->x.at[a], m->x.at[last], n[1]);
    pbwsf__normal(m->x.at[a], m->x.at[last], m->x.at[first], n[2]);
    pbwsf__normal(m->x.at[b], m->x.at[first], m->x.at[last], n[3]);
    if (!pbwim__turned_less(n[0], n[1], m->turn) || pbwim__is_border(m, ring)
        || pbwim__is_frozen(m, ring)) {
        return 0;
    }
    for (i = 0; i < 3; i++) {
        sum[i] = n[0][i] + n[1][i];
    }
    if (!pbwim__turned_less(n[2], sum, m->turn) || !pbwim__turned_less(n[3], sum, m->turn)
        || !pbwim__turned_less(n[2], n[3], m->turn)) {
        return 0;
    }
    count = pbwim__star_of(m, first, star);                  /* is there such an edge already? */
    for (i = 0; i < count && pbwim__corner_of(m, star[i], last) == 4; i++) {
    }
    return count > 0 && i == count && pbwim__flip_stays_near(m, ring);
}

/* ------------------------------------------------------------------------------------------------------
   >>flips        Operations of every pass: edge removal, smoothing, peeling, 2-3 flips.
   In: a mesh and a tetrahedron of it.  Out: 1 if the mesh is changed, else 0.
   Holds: an operation raises the least quality of the tetrahedra that it changes, by PBWIM__GAIN or more.
   ------------------------------------------------------------------------------------------------------ */

/* ---- edge removal ---- */

typedef struct pbwim__table {              /* of the dynamic programme: polygons from ring corner i to k */
    double best[PBWIM__RING + 1][PBWIM__RING + 1];
    signed char apex[PBWIM__RING + 1][PBWIM__RING + 1];
} pbwim__table;

static double pbwim__pair_sine(const pbwim__mesh *m, const pbwim__ring *ring, int i, int j, int k)
{
    const double *p = m->x.at[ring->corner[i]], *q = m->x.at[ring->corner[j]];
    const double *r = m->x.at[ring->corner[k]];
    const double above = pbwim__sine(p, q, r, m->x.at[ring->b]);
    return above <= 0 ? above : fmin(above, pbwim__sine(q, p, r, m->x.at[ring->a]));
}

/* Finds the best triangulation of the ring's polygon.  Returns its least sine, or a number not above `least`. */
static double pbwim__triangulate(const pbwim__mesh *m, const pbwim__ring *ring, double least, pbwim__table *table)
{
    int i, j, k, length;
    for (i = 0; i + 1 < ring->corners; i++) {
        table->best[i][i + 1] = 2;
    }
    for (length = 2; length < ring->corners; length++) {
        for (i = 0; i + length < ring->corners; i++) {
            k = i + length;
            table->best[i][k] = -2;
            for (j = i + 1; j < k; j++) {
                const double sides = fmin(table->best[i][j], table->best[j][k]);
                if (sides > least && sides > table->best[i][k]) {
                    const double all = fmin(sides, pbwim__pair_sine(m, ring, i, j, k));
                    if (all > table->best[i][k]) {
                        table->best[i][k] = all;
                        table->apex[i][k] = (signed char)j;
                    }
                }
            }
        }
    }
    return table->best[0][ring->corners - 1];
}

/* The tetrahedra of the table's triangulation. */
static void pbwim__read_table(const pbwim__ring *ring, const pbwim__table *table, pbwim__change *change)
{
    int stack[2 * PBWIM__RING][2], depth = 1;
    stack[0][0] = 0;
    stack[0][1] = ring->corners - 1;
    change->news = 0;
    while (depth > 0) {
        const int i = stack[--depth][0], k = stack[depth][1], j = table->apex[i][k];
        pbw_index *up = change->fresh[change->news], *down = change->fresh[change->news + 1];
        up[0] = ring->corner[i], up[1] = ring->corner[j], up[2] = ring->corner[k], up[3] = ring->b;
        down[0] = ring->corner[j], down[1] = ring->corner[i], down[2] = ring->corner[k], down[3] = ring->a;
        change->news += 2;
        if (j - i > 1) {
            stack[depth][0] = i;
            stack[depth++][1] = j;
        }
        if (k - j > 1) {
            stack[depth][0] = j;
            stack[depth++][1] = k;
        }
    }
}

static int pbwim__remove_edge(pbwim__mesh *m, pbw_index t)
{
    pbwim__ring ring, chosen;
    pbwim__table table, chosen_table;
    pbwim__change change;
    double best = 0;
    int e, i;
    memset(&chosen, 0, sizeof chosen);
    for (e = 0; e < 6; e++) {
        double worst = 2, reached;
        ring.a = m->corner.at[t][pbwim__edge[e][0]];
        ring.b = m->corner.at[t][pbwim__edge[e][1]];
        if (!pbwim__walk_ring(m, t, &ring) || ring.corners < 3) {
            continue;
        }
        for (i = 0; i < ring.tets; i++) {
            worst = fmin(worst, m->quality.at[ring.tet[i]]);
        }
        reached = pbwim__triangulate(m, &ring, fmax(worst + PBWIM__GAIN, best), &table);
        if (reached > fmax(worst + PBWIM__GAIN, best) && (ring.closed || pbwim__may_flip(m, &ring))) {
            best = reached;
            chosen = ring;
            chosen_table = table;
        }
    }
    if (chosen.corners == 0) {
        return 0;
    }
    pbwim__read_table(&chosen, &chosen_table, &change);
    change.halves = 0;
    change.olds = chosen.tets;
    memcpy(change.old, chosen.tet, sizeof chosen.tet);
    if (!pbwim__is_sound(m, &change)) {
        return 0;
    }
    pbwim__apply(m, &change);
    m->report->removals += chosen.closed != 0;
    m->report->boundary_removals += chosen.closed == 0;
    return 1;
}

/* ---- cones: facets seen from one point ---- */

typedef struct pbwim__cone { int count; pbw_index facet[PBWIM__MOST][3]; } pbwim__cone;

/* Returns the least sine of the tetrahedra from the facets to x, or a number not above `least`.  The facet that
   decides is tested first the next time. */
static double pbwim__cone_sine(pbwim__mesh *m, pbwim__cone *cone, const double x[3], double least)
{
    double worst = 2;
    int i;
    for (i = 0; i < cone->count; i++) {
        const pbw_index *f = cone->facet[i];
        const double sine = pbwim__sine(m->x.at[f[0]], m->x.at[f[1]], m->x.at[f[2]], x);
        worst = sine < worst ? sine : worst;
        if (worst <= least) {
            pbw_index swap[3];
            memcpy(swap, cone->facet[0], sizeof swap);
            memcpy(cone->facet[0], cone->facet[i], sizeof swap);
            memcpy(cone->facet[i], swap, sizeof swap);
            break;
        }
    }
    m->effort += (size_t)i;
    return worst;
}

/* Eight directions across the normal, or fourteen of space.  Returns how many. */
static int pbwim__directions(const double *normal, double direction[14][3])
{
    static const double round[8][2] = { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 },
                                        { .7071, .7071 }, { -.7071, .7071 }, { .7071, -.7071 }, { -.7071, -.7071 } };
    double side[3] = { 0, 0, 0 }, other[3], length;
    int i, k;
    if (normal == NULL) {
        for (i = 0; i < 6; i++) {
            for (k = 0; k < 3; k++) {
                direction[i][k] = k != i / 2 ? 0 : i % 2 == 0 ? 1 : -1;
            }
        }
        for (; i < 14; i++) {
            for (k = 0; k < 3; k++) {
                direction[i][k] = (i - 6) >> k & 1 ? -.577 : .577;
            }
        }
        return 14;
    }
    k = fabs(normal[0]) < fabs(normal[1]) ? 0 : 1;
    side[fabs(normal[2]) < fabs(normal[k]) ? 2 : k] = 1;
    pbwsf__cross(normal, side, other);
    pbwsf__cross(normal, other, side);
    for (k = 0, length = sqrt(pbwsf__dot(other, other)); k < 3; k++) {
        other[k] = length > 0 ? other[k] / length : 0;
    }
    for (k = 0, length = sqrt(pbwsf__dot(side, side)); k < 3; k++) {
        side[k] = length > 0 ? side[k] / length : 0;
    }
    for (i = 0; i < 8; i++) {
        for (k = 0; k < 3; k++) {
            direction[i][k] = round[i][0] * side[k] + round[i][1] * other[k];
        }
    }
    return 8;
}

/* Turns the directions around the normal, or in space around a random axis, by a random angle. */
static void pbwim__turn_directions(const double *normal, uint64_t key, int count, double direction[14][3])
{
    double axis[3], across[3], length, u[4];
    int i, k;
    for (i = 0; i < 4; i++) {                        /* from -1 to 1 */
        u[i] = (double)(pbw_random(key, (uint64_t)i) >> 11) / 4503599627370496.0 - 1;
    }
    memcpy(axis, normal != NULL ? normal : u + 1, sizeof axis);
    length = sqrt(pbwsf__dot(axis, axis));
    for (i = 0; i < count && length > 0; i++) {      /* Rodrigues' formula; u[0] is the tangent of half the angle */
        const double sine = 2 * u[0] / (1 + u[0] * u[0]), cosine = (1 - u[0] * u[0]) / (1 + u[0] * u[0]);
        const double along = (1 - cosine) * pbwsf__dot(axis, direction[i]) / (length * length);
        pbwsf__cross(axis, direction[i], across);
        for (k = 0; k < 3; k++) {
            direction[i][k] = cosine * direction[i][k] + sine * across[k] / length + along * axis[k];
        }
    }
}

/* Hill climbing: moves x to a nearby maximum of the cone's least sine.  Each step takes the best of some directions;
   if none is better, steps become half as long.  from: the sine at x.  With the normal of a surface, x stays on it;
   places with a clearly lower sine are not projected, as projecting takes longest.  Returns the sine at the last x.
   */
static double pbwim__climb(pbwim__mesh *m, pbwim__cone *cone, const double *normal, double from, double x[3])
{
    double direction[14][3], best = from, length = 0, step;
    const int directions = pbwim__directions(normal, direction);
    int i, k, moves;
    for (i = 0; i < cone->count; i++) {
        length += pbwsf__distance(m->x.at[cone->facet[i][0]], m->x.at[cone->facet[i][1]]) / cone->count;
    }
    for (step = 0.2 * length, moves = 0; step > 0.01 * length && moves < 40 && best < m->target; moves++) {
        double place[3], chosen[3], reached = best;
        if (m->turned) {
            pbwim__turn_directions(normal, (uint64_t)m->clock << 6 | (uint64_t)moves, directions, direction);
        }
        for (i = 0; i < directions; i++) {
            double sine;
            for (k = 0; k < 3; k++) {
                place[k] = x[k] + step * direction[i][k];
            }
            if (normal != NULL) {
                const double nearby = reached - 0.1 * fabs(reached);
                if (pbwim__cone_sine(m, cone, place, nearby) <= nearby) {
                    continue;
                }
                m->project(m->project_user, place);
                m->effort += PBWIM__PROJECTION;
            }
            sine = pbwim__cone_sine(m, cone, place, reached);
            if (sine > reached) {
                reached = sine;
                memcpy(chosen, place, sizeof chosen);
            }
        }
        if (reached > best) {
            best = reached;
            memcpy(x, chosen, sizeof chosen);
        } else {
            step /= 2;
        }
    }
    return best;
}

/* Adds the normals of the boundary facets of t at p, or at all of its corners if that is PBW_NONE. */
static void pbwim__add_normals(const pbwim__mesh *m, pbw_index t, pbw_index p, double sum[3])
{
    double n[3];
    int i, k;
    for (i = 0; i < 4; i++) {
        if (m->next.at[t][i] == PBW_NONE && m->corner.at[t][i] != p) {
            pbwim__outward(m, t, i, n);
            for (k = 0; k < 3; k++) {
                sum[k] += n[k];
            }
        }
    }
}

/* Fills the cone with the facets across from p of its star. */
static void pbwim__cone_of(const pbwim__mesh *m, pbw_index p, const pbw_index *star, int count, pbwim__cone *cone)
{
    int i, k;
    for (i = 0; i < count; i++) {
        const pbw_index *c = m->corner.at[star[i]];
        const int *o = pbwim__opposite[pbwim__corner_of(m, star[i], p)];
        for (k = 0; k < 3; k++) {
            cone->facet[i][k] = c[o[k]];
        }
    }
    cone->count = count;
}

/* Middles of the boundary facets at a point: of their edges across from it, or else of the facets and of their edges
   at it, which move with it. */
typedef struct pbwim__middles {
    pbw_index p;
    const pbw_index *star;                           /* the tetrahedra at p */
    int count, across;
} pbwim__middles;

/* Returns the largest distance of these middles from the surface, were p at x, or `least`; it may end once that is
   above `enough`. */
static double pbwim__farthest_at(const pbwim__mesh *m, const pbwim__middles *of, const double *x, double least,
                                 double enough)
{
    const pbw_index p = of->p;
    int i, k, j;
    for (i = 0; i < of->count; i++) {
        const pbw_index t = of->star[i], *c = m->corner.at[t];
        for (k = 0; k < 4 && least <= enough; k++) {
            const int *o = pbwim__opposite[k];
            const int at = c[o[0]] == p ? 0 : c[o[1]] == p ? 1 : 2;
            const double *corner[3];
            double middle[2][3];
            if (c[k] == p || m->next.at[t][k] != PBW_NONE) {
                continue;
            }
            for (j = 0; j < 3; j++) {
                corner[j] = j == at ? x : m->x.at[c[o[j]]];
            }
            for (j = 0; j < 3; j++) {                /* of two edges at p, one; the other is the next facet's */
                const double *a = of->across ? corner[(at + 2) % 3] : x, *b = corner[(at + 1) % 3];
                middle[0][j] = 0.5 * a[j] + 0.5 * b[j];
                middle[1][j] = 1.0 / 3 * corner[0][j] + 1.0 / 3 * corner[1][j] + 1.0 / 3 * corner[2][j];
            }
            for (j = 0; j < (of->across ? 1 : 2); j++) {
                double place[3];
                memcpy(place, middle[j], sizeof place);
                m->project(m->project_user, place);
                least = fmax(least, pbwsf__distance(middle[j], place));
            }
        }
    }
    return least;
}

/* Returns whether the boundary facets at p stay near the surface where p moves to x: within the distance, or as near
   as they are, their edges across from p included. */
static int pbwim__move_stays_near(const pbwim__mesh *m, pbw_index p, const double *x, const pbw_index *star,
                                  int count)
{
    const pbwim__middles moving = { p, star, count, 0 }, across = { p, star, count, 1 };
    double after, before;
    if (!(m->distance > 0)) {
        return 1;
    }
    after = pbwim__farthest_at(m, &moving, x, 0, HUGE_VAL);
    if (after <= m->distance) {
        return 1;
    }
    before = pbwim__farthest_at(m, &moving, m->x.at[p], 0, after);
    return after <= pbwim__farthest_at(m, &across, m->x.at[p], before, after);
}

static int pbwim__smooth(pbwim__mesh *m, pbw_index p)
{
    pbw_index star[PBWIM__MOST];
    pbwim__cone cone;
    double before[3], worst = 2, x[3], normal[3] = { 0, 0, 0 };
    const int slides = m->mark.at[p] == PBW_TETS_SLIDES;
    int count, i, k;
    if (m->mark.at[p] >= PBW_TETS_FIXED || m->touched.at[p] <= m->failed.at[p]) {
        return 0;
    }
    count = pbwim__star_of(m, p, star);
    for (i = 0; i < count; i++) {
        worst = fmin(worst, m->quality.at[star[i]]);
    }
    if (count == 0 || worst >= m->target) {
        return 0;
    }
    m->failed.at[p] = m->clock;                      /* unless it is touched: below */
    for (i = 0; i < count && slides; i++) {
        pbwim__add_normals(m, star[i], p, normal);
    }
    pbwim__cone_of(m, p, star, count, &cone);
    memcpy(before, m->x.at[p], sizeof before);
    memcpy(x, before, sizeof x);
    if (pbwim__climb(m, &cone, slides ? normal : NULL, worst, x)
        <= worst + fmax(PBWIM__GAIN, m->smooth_gain * (m->target - worst))
        || (slides && !pbwim__move_stays_near(m, p, x, star, count))) {
        return 0;
    }
    memcpy(m->x.at[p], x, sizeof x);
    for (i = 0; i < count && pbwim__sign_of(m, m->corner.at[star[i]]) > 0; i++) {
    }
    if (i < count) {
        memcpy(m->x.at[p], before, sizeof before);
        return 0;
    }
    m->clock++;
    for (i = 0; i < count; i++) {
        m->quality.at[star[i]] = pbwim__sine_of(m, m->corner.at[star[i]]);
        for (k = 0; k < 4; k++) {
            m->touched.at[m->corner.at[star[i]][k]] = m->clock;
        }
    }
    *(slides ? &m->report->slides : &m->report->smoothings) += 1;
    return 1;
}

/* ---- at the boundary ---- */

/* Returns whether the boundary stays a manifold without t.  With one boundary facet, the opposite corner comes to the
   boundary, and must be inside before; with two, so must the opposite edge; with three, their common corner is lost,
   and must be on a smooth part. */
static int pbwim__may_peel(pbwim__mesh *m, pbw_index t)
{
    const pbw_index *c = m->corner.at[t], *next = m->next.at[t];
    pbw_index star[PBWIM__MOST];
    pbwim__ring ring;
    int on[4], off[4], outer = 0, inner = 0, i, k, count;
    for (i = 0; i < 4; i++) {
        if (next[i] == PBW_NONE) {
            on[outer++] = i;
        } else {
            off[inner++] = i;
        }
    }
    if (outer == 2) {
        ring.a = c[on[0]];
        ring.b = c[on[1]];
        return pbwim__walk_ring(m, t, &ring) && ring.closed;
    }
    if (outer == 3) {
        return m->mark.at[c[off[0]]] == PBW_TETS_SLIDES;
    }
    if (outer != 1 || m->mark.at[c[on[0]]] != PBW_TETS_FOUND) {
        return 0;
    }
    count = pbwim__star_of(m, c[on[0]], star);
    for (i = 0; i < count; i++) {
        for (k = 0; k < 4; k++) {
            if (m->corner.at[star[i]][k] != c[on[0]] && m->next.at[star[i]][k] == PBW_NONE) {
                return 0;
            }
        }
    }
    return count > 0;
}

/* Returns whether the facets beneath the boundary facets of t are near the surface. */
static int pbwim__peel_stays_near(const pbwim__mesh *m, pbw_index t)
{
    const pbw_index *c = m->corner.at[t];
    double before = 0, after = 0;
    int i;
    for (i = 0; i < 4 && m->distance > 0; i++) {
        const int *o = pbwim__opposite[i];
        double *most = m->next.at[t][i] == PBW_NONE ? &before : &after;
        *most = pbwim__farthest(m, m->x.at[c[o[0]]], m->x.at[c[o[1]]], m->x.at[c[o[2]]], *most);
    }
    return after <= fmax(m->distance, before);
}

/* Returns whether peeling t keeps patches and edges: its boundary facets are of one patch and not frozen, its other
   facets of none, and no edge of it is to be kept. */
static int pbwim__peel_keeps_patches(const pbwim__mesh *m, pbw_index t)
{
    const pbw_index *c = m->corner.at[t], *next = m->next.at[t];
    int i, first = -1;
    for (i = 0; i < 4 && m->patched; i++) {
        const pbw_index *patch = m->patch.at[t];
        first = next[i] == PBW_NONE && first < 0 ? i : first;
        if (next[i] == PBW_NONE ? patch[i] != patch[first] : patch[i] != PBW_NONE) {
            return 0;
        }
    }
    for (i = 0; i < 4; i++) {
        if (pbwim__is_frozen_facet(m, t, i)) {
            return 0;
        }
    }
    for (i = 0; i < 6; i++) {
        if (pbwim__is_kept(m, c[pbwim__edge[i][0]], c[pbwim__edge[i][1]])) {
            return 0;
        }
    }
    return 1;
}

/* Peels off a tetrahedron at the boundary, if its facets there and those beneath are nearly in one plane. */
static int pbwim__peel(pbwim__mesh *m, pbw_index t)
{
    const pbw_index *next = m->next.at[t];
    pbwim__change change;
    double n[4][3];
    int i, k;
    if (next[0] != PBW_NONE && next[1] != PBW_NONE && next[2] != PBW_NONE && next[3] != PBW_NONE) {
        return 0;
    }
    for (i = 0; i < 4; i++) {
        pbwim__outward(m, t, i, n[i]);
        for (k = 0; k < 3 && next[i] != PBW_NONE; k++) {
            n[i][k] = -n[i][k];
        }
    }
    for (i = 0; i < 4; i++) {
        for (k = 0; k < i; k++) {
            if (!pbwim__turned_less(n[i], n[k], m->turn)) {
                return 0;
            }
        }
    }
    if (!pbwim__may_peel(m, t) || !pbwim__peel_keeps_patches(m, t) || !pbwim__peel_stays_near(m, t)) {
        return 0;
    }
    change.olds = 1;
    change.news = change.halves = 0;
    change.old[0] = t;
    for (i = 0; i < 4; i++) {                        /* corners that were inside are on the boundary now */
        unsigned char *mark = m->mark.at + m->corner.at[t][i];
        *mark = *mark == PBW_TETS_FOUND ? PBW_TETS_SLIDES : *mark;
    }
    pbwim__apply(m, &change);
    m->report->peelings++;
    return 1;
}

/* ---- 2-3 flips ---- */

static int pbwim__flip(pbwim__mesh *m, pbw_index t)
{
    pbwim__change change;
    int i, k;
    for (i = 0; i < 4; i++) {
        const pbw_index *c = m->corner.at[t], n = m->next.at[t][i];
        const int *o = pbwim__opposite[i];
        double worst;
        if (n == PBW_NONE) {
            continue;
        }
        change.halves = 0;
        change.olds = 2;
        change.old[0] = t;
        change.old[1] = n;
        worst = pbwim__worst_old(m, &change) + PBWIM__GAIN;
        change.news = 3;
        for (k = 0; k < 3; k++) {                    /* facet (f0 f1 f2), c[i] above and the other below it */
            pbw_index *fresh = change.fresh[k];
            fresh[0] = c[o[k]];
            fresh[1] = c[o[(k + 1) % 3]];
            fresh[2] = m->corner.at[n][pbwim__facet_to(m, n, t)];
            fresh[3] = c[i];
            if (pbwim__sine_of(m, fresh) <= worst) {
                break;
            }
        }
        if (k == 3 && pbwim__is_sound(m, &change)) {
            pbwim__apply(m, &change);
            m->report->flips++;
            return 1;
        }
    }
    return 0;
}

/* ------------------------------------------------------------------------------------------------------
   >>insertion    Operations of thorough passes: contraction, rejoining, insertion.
   In: a mesh and a tetrahedron of it.  Out: 1 if the mesh is changed, else 0.
   Holds: an operation raises the least quality of the tetrahedra that it changes, by PBWIM__GAIN or more; a cavity
   stays within the zone of its tetrahedron (>>passes).
   ------------------------------------------------------------------------------------------------------ */
/* ---- contraction ---- */

/* Returns whether p may move along a boundary edge to q: the boundary around p stays smooth. */
static int pbwim__may_slide_to(const pbwim__mesh *m, pbw_index p, pbw_index q, const pbw_index *star, int count)
{
    int i, k;
    for (i = 0; i < count; i++) {
        const pbw_index *c = m->corner.at[star[i]];
        if (pbwim__corner_of(m, star[i], q) < 4) {
            continue;
        }
        for (k = 0; k < 4; k++) {
            if (c[k] != p && m->next.at[star[i]][k] == PBW_NONE) {
                const int *o = pbwim__opposite[k];
                double n[2][3];
                pbwim__outward(m, star[i], k, n[0]);
                pbwsf__normal(m->x.at[c[o[0]] == p ? q : c[o[0]]], m->x.at[c[o[2]] == p ? q : c[o[2]]],
                              m->x.at[c[o[1]] == p ? q : c[o[1]]], n[1]);
                if (!pbwim__turned_less(n[0], n[1], m->turn)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Returns whether a corner of the old tetrahedra other than p is in none of the new ones. */
static int pbwim__loses_corner(const pbwim__mesh *m, const pbwim__change *change, pbw_index p)
{
    int i, k;
    for (i = 0; i < 4 * change->olds; i++) {
        const pbw_index v = m->corner.at[change->old[i / 4]][i % 4];
        for (k = 0; k < 4 * change->news && change->fresh[k / 4][k % 4] != v; k++) {
        }
        if (k == 4 * change->news && v != p) {
            return 1;
        }
    }
    return 0;
}

/* The link condition: returns whether p and q have no common neighbours but the ring of their edge (Dey,
   Edelsbrunner, Guha, Nekhayev 1999, "Topology preserving edge contraction"). */
static int pbwim__link_condition(pbwim__mesh *m, pbw_index q, const pbwim__ring *ring, const pbwim__cone *cone)
{
    pbw_index star[PBWIM__MOST], corner[3 * PBWIM__MOST];
    const int count = pbwim__star_of(m, q, star);
    int i, j, k, corners = 0;
    for (i = 0; i < cone->count; i++) {              /* p's neighbours that are not in the ring */
        for (k = 0; k < 3; k++) {
            const pbw_index v = cone->facet[i][k];
            for (j = 0; j < ring->corners && ring->corner[j] != v; j++) {
            }
            if (j == ring->corners && v != q) {
                corner[corners++] = v;
            }
        }
    }
    for (i = 0; i < count; i++) {
        for (j = 0; j < corners; j++) {
            if (pbwim__corner_of(m, star[i], corner[j]) < 4) {
                return 0;
            }
        }
    }
    return count > 0;
}

/* Contracts the edge of t from p to q, if the least sine rises or stays above `floor`. */
static int pbwim__contract_to(pbwim__mesh *m, pbw_index t, pbw_index p, pbw_index q, double floor)
{
    pbwim__change change;
    pbwim__cone cone;
    pbwim__ring ring;
    const int slides = m->mark.at[p] == PBW_TETS_SLIDES;
    double worst;
    int i;
    ring.a = p;
    ring.b = q;
    if (m->mark.at[p] >= PBW_TETS_FIXED || !pbwim__walk_ring(m, t, &ring) || (slides && ring.closed)) {
        return 0;
    }
    change.halves = 0;
    change.olds = pbwim__star_of(m, p, change.old);
    if (change.olds == 0) {
        return 0;
    }
    pbwim__cone_of(m, p, change.old, change.olds, &cone);
    worst = fmin(pbwim__worst_old(m, &change) + PBWIM__GAIN, floor);
    for (i = change.news = 0; i < change.olds; i++) {
        pbw_index *fresh = change.fresh[change.news];
        if (pbwim__corner_of(m, change.old[i], q) == 4) {
            memcpy(fresh, cone.facet[i], 3 * sizeof *fresh);
            fresh[3] = q;
            if (pbwim__sine_of(m, fresh) <= worst) {
                return 0;
            }
            change.news++;
        }
    }
    if (change.news == 0 || !pbwim__is_sound(m, &change) || pbwim__loses_corner(m, &change, p)
        || (slides && (!pbwim__may_slide_to(m, p, q, change.old, change.olds)
                       || !pbwim__move_stays_near(m, p, m->x.at[q], change.old, change.olds)))
        || !pbwim__link_condition(m, q, &ring, &cone)) {
        return 0;
    }
    pbwim__apply(m, &change);
    m->report->contractions++;
    return 1;
}

static int pbwim__contract(pbwim__mesh *m, pbw_index t)
{
    int e;
    for (e = 0; e < 6; e++) {
        const pbw_index a = m->corner.at[t][pbwim__edge[e][0]], b = m->corner.at[t][pbwim__edge[e][1]];
        if (pbwim__contract_to(m, t, a, b, 2) || pbwim__contract_to(m, t, b, a, 2)) {
            return 1;
        }
    }
    return 0;
}

/* ---- insertion ---- */

enum { PBWIM__CAVITY = 60 };               /* tetrahedra of a cavity that grows, at most */

typedef struct pbwim__cavity {             /* change->old, whose facets are joined to a point */
    pbwim__change *change;
    const pbwim__ring *split;              /* boundary facets at this edge are replaced; NULL = none */
    pbw_index t, p;                        /* the tetrahedron to improve; the point, PBW_NONE if it is new */
    const double *x;                       /* its place */
    pbwim__cone cone;
    pbw_index across[PBWIM__MOST];         /* across each facet, PBW_NONE on the boundary */
    double sine[PBWIM__MOST];              /* of the tetrahedron from each facet to x */
} pbwim__cavity;

/* Returns whether a boundary facet is replaced: it has the point, or both ends of the edge that is split. */
static int pbwim__is_replaced(const pbwim__cavity *v, const pbw_index f[3])
{
    const pbw_index a = v->split != NULL ? v->split->a : v->p, b = v->split != NULL ? v->split->b : v->p;
    return a != PBW_NONE && (f[0] == a || f[1] == a || f[2] == a) && (f[0] == b || f[1] == b || f[2] == b);
}

/* Adds the facets of a tetrahedron of the cavity that no other of it has. */
static void pbwim__add_facets(const pbwim__mesh *m, pbwim__cavity *v, pbw_index t)
{
    int k, j;
    for (k = 0; k < 4; k++) {
        const pbw_index *c = m->corner.at[t], n = m->next.at[t][k];
        pbw_index *f = v->cone.facet[v->cone.count];
        for (j = 0; j < 3; j++) {
            f[j] = c[pbwim__opposite[k][j]];
        }
        if (n == PBW_NONE ? !pbwim__is_replaced(v, f) : m->seen.at[n] != m->visit) {
            v->across[v->cone.count] = n;
            v->sine[v->cone.count++] = pbwim__sine(m->x.at[f[0]], m->x.at[f[1]], m->x.at[f[2]], v->x);
        }
    }
}

/* Fills the cone. */
static void pbwim__open_cavity(pbwim__mesh *m, pbwim__cavity *v)
{
    int i;
    pbwim__visit(m);
    for (i = 0; i < v->change->olds; i++) {
        m->seen.at[v->change->old[i]] = m->visit;
    }
    for (i = v->cone.count = 0; i < v->change->olds; i++) {
        pbwim__add_facets(m, v, v->change->old[i]);
    }
}

/* Returns whether a tetrahedron may join the cavity: it is at a corner of t, so it is in the zone of the task. */
static int pbwim__may_grow(const pbwim__mesh *m, const pbwim__cavity *v, pbw_index n)
{
    const pbw_index *c = m->corner.at[v->t];
    return n != PBW_NONE && m->region.at[n] == m->region.at[v->t]
        && (v->p == PBW_NONE || pbwim__corner_of(m, n, v->p) == 4)
        && (pbwim__corner_of(m, n, c[0]) < 4 || pbwim__corner_of(m, n, c[1]) < 4 || pbwim__corner_of(m, n, c[2]) < 4
            || pbwim__corner_of(m, n, c[3]) < 4);
}

/* Grows the cavity, always across the facet that has the worst tetrahedron to x, then returns to the size at which
   this worst was best.  Returns its sine. */
static double pbwim__grow_cavity(pbwim__mesh *m, pbwim__cavity *v)
{
    pbwim__change *change = v->change;
    double best = -2;
    int kept = change->olds, worst, i;
    pbwim__open_cavity(m, v);
    for (;;) {
        pbw_index n;
        for (i = 1, worst = 0; i < v->cone.count; i++) {
            worst = v->sine[i] < v->sine[worst] ? i : worst;
        }
        if (v->sine[worst] > best && v->cone.count - change->olds <= PBWIM__SPARE) {
            best = v->sine[worst];
            kept = change->olds;
        }
        n = v->across[worst];
        if (v->sine[worst] >= m->target || change->olds >= PBWIM__CAVITY || v->cone.count > PBWIM__MOST - 4
            || !pbwim__may_grow(m, v, n)) {
            break;
        }
        for (i = v->cone.count; i-- > 0;) {
            if (v->across[i] == n) {
                v->cone.count--;
                memcpy(v->cone.facet[i], v->cone.facet[v->cone.count], sizeof v->cone.facet[i]);
                v->across[i] = v->across[v->cone.count];
                v->sine[i] = v->sine[v->cone.count];
            }
        }
        m->seen.at[n] = m->visit;
        change->old[change->olds++] = n;
        pbwim__add_facets(m, v, n);
    }
    if (kept < change->olds) {
        change->olds = kept;
        pbwim__open_cavity(m, v);
    }
    return best;
}

/* Joins the cavity's facets to p, if all tetrahedra are positive. */
static int pbwim__fill_cavity(pbwim__mesh *m, pbwim__cavity *v, pbw_index p)
{
    pbwim__change *change = v->change;
    int i;
    for (i = 0; i < v->cone.count; i++) {
        memcpy(change->fresh[i], v->cone.facet[i], sizeof v->cone.facet[i]);
        change->fresh[i][3] = p;
    }
    change->news = v->cone.count;
    change->halves = 0;
    return pbwim__is_sound(m, change) && !pbwim__loses_corner(m, change, p);
}

/* Joins a corner of t to the facets of a cavity around its star, if the tetrahedra get better. */
static int pbwim__rejoin(pbwim__mesh *m, pbw_index t)
{
    pbwim__change change;
    pbwim__cavity v;
    int k;
    v.change = &change;
    v.split = NULL;
    v.t = t;
    for (k = 0; k < 4; k++) {
        double best;
        v.p = m->corner.at[t][k];
        v.x = m->x.at[v.p];
        change.olds = pbwim__star_of(m, v.p, change.old);
        if (change.olds == 0 || change.olds >= PBWIM__CAVITY) {
            continue;
        }
        best = pbwim__grow_cavity(m, &v);
        if (best > pbwim__worst_old(m, &change) + PBWIM__GAIN && pbwim__fill_cavity(m, &v, v.p)) {
            pbwim__apply(m, &change);
            m->report->flips++;
            return 1;
        }
    }
    return 0;
}

/* Inserts a point near x into the tetrahedra change->old and some around them.  Their boundary facets with both ends
   of `split` are replaced; others stay. */
static int pbwim__insert(pbwim__mesh *m, pbw_index t, pbwim__change *change, const pbwim__ring *split, double x[3])
{
    const pbw_index p = (pbw_index)m->points;
    const int slides = split != NULL && !split->closed;
    double normal[3] = { 0, 0, 0 }, best;
    pbwim__cavity v;
    v.change = change;
    v.split = slides ? split : NULL;
    v.t = t;
    v.p = PBW_NONE;
    v.x = x;
    if (slides) {
        m->project(m->project_user, x);
        pbwim__add_normals(m, split->tet[0], PBW_NONE, normal);
        pbwim__add_normals(m, split->tet[split->tets - 1], PBW_NONE, normal);
    }
    best = pbwim__grow_cavity(m, &v);
    best = pbwim__climb(m, &v.cone, slides ? normal : NULL, best, x);
    if (best < m->target) {                          /* the cavity of the new x may be larger */
        best = pbwim__climb(m, &v.cone, slides ? normal : NULL, pbwim__grow_cavity(m, &v), x);
    }
    if (best <= pbwim__worst_old(m, change) + PBWIM__GAIN) {
        return 0;
    }
    memcpy(m->x.at[p], x, 3 * sizeof(double));
    if (!pbwim__fill_cavity(m, &v, p)) {
        return 0;
    }
    m->points++;
    m->mark.at[p] = slides ? PBW_TETS_SLIDES : PBW_TETS_FOUND;
    m->original.at[p] = PBW_NONE;
    if (m->sized) {
        m->size.at[p] = m->size.at[v.cone.facet[0][0]];
    }
    if (m->placed > 0) {
        memcpy(m->place.at[p], m->place.at[v.cone.facet[0][0]], sizeof m->place.at[p]);
    }
    pbwim__apply(m, change);
    m->report->insertions++;
    return 1;
}

/* Inserts a point across a facet of t, half or a quarter of the way to the neighbour's corner: t may be too flat for
   a point inside. */
static int pbwim__insert_across(pbwim__mesh *m, pbw_index t)
{
    pbwim__change change;
    int i, k;
    for (i = 0; i < 8; i++) {
        const pbw_index n = m->next.at[t][i % 4], *c = m->corner.at[t];
        const int *o = pbwim__opposite[i % 4];
        double middle[3], x[3];
        if (n == PBW_NONE) {
            continue;
        }
        for (k = 0; k < 3; k++) {
            middle[k] = (m->x.at[c[o[0]]][k] + m->x.at[c[o[1]]][k] + m->x.at[c[o[2]]][k]) / 3;
        }
        pbwsf__between(middle, m->x.at[m->corner.at[n][pbwim__facet_to(m, n, t)]], i < 4 ? 0.5 : 0.25, x);
        change.olds = 2;
        change.old[0] = t;
        change.old[1] = n;
        if (pbwim__insert(m, t, &change, NULL, x)) {
            return 1;
        }
    }
    return 0;
}

/* Splits an edge of t, or puts a point into t and its neighbours. */
static int pbwim__split(pbwim__mesh *m, pbw_index t)
{
    pbwim__change change;
    pbwim__ring ring;
    double x[3] = { 0, 0, 0 }, n[2][3];
    int e, i, k;
    for (e = 0; e < 6; e++) {
        ring.a = m->corner.at[t][pbwim__edge[e][0]];
        ring.b = m->corner.at[t][pbwim__edge[e][1]];
        if (!pbwim__walk_ring(m, t, &ring)) {
            continue;
        }
        pbwsf__normal(m->x.at[ring.a], m->x.at[ring.b], m->x.at[ring.corner[0]], n[0]);
        pbwsf__normal(m->x.at[ring.b], m->x.at[ring.a], m->x.at[ring.corner[ring.corners - 1]], n[1]);
        if (!ring.closed && (!pbwim__turned_less(n[0], n[1], m->turn) || pbwim__is_border(m, &ring)
                             || pbwim__is_frozen(m, &ring))) {
            continue;
        }
        pbwsf__between(m->x.at[ring.a], m->x.at[ring.b], 0.5, x);
        change.olds = ring.tets;
        memcpy(change.old, ring.tet, sizeof ring.tet);
        if (pbwim__insert(m, t, &change, &ring, x)) {
            return 1;
        }
    }
    change.olds = 1;
    change.old[0] = t;
    memset(x, 0, sizeof x);
    for (i = 0; i < 4; i++) {
        if (m->next.at[t][i] != PBW_NONE) {
            change.old[change.olds++] = m->next.at[t][i];
        }
        for (k = 0; k < 3; k++) {
            x[k] += 0.25 * m->x.at[m->corner.at[t][i]][k];
        }
    }
    return pbwim__insert(m, t, &change, NULL, x) || pbwim__insert_across(m, t);
}

/* ------------------------------------------------------------------------------------------------------
   >>load         Neighbours, orientation, the boundary and its features.
   In: the caller's arrays.  Out: a mesh as above, or a status and a message.
   ------------------------------------------------------------------------------------------------------ */
static void pbwim__set_message(const pbwim__mesh *m, const char *text, size_t i, size_t k)
{
    if (m->options != NULL && m->options->message != NULL && m->options->message_size > 0) {
        snprintf(m->options->message, m->options->message_size, text, i, k);
    }
}

typedef struct pbwim__sorting {            /* start from zeros */
    pbwim__facets items, other;
    pbwsf__counts first;                   /* per number in column 0: where its items begin; in the end, where they
                                              end */
    int (*compare)(const void *x, const void *y);    /* items of one number */
} pbwim__sorting;

/* Makes room for items of numbers below `range`.  Returns 0 if there is no memory. */
static int pbwim__begin_sorting(pbw_memory *memory, pbwim__sorting *s, size_t count, size_t range)
{
    return PBW_FIT(memory, s->items, count + 1) && PBW_FIT(memory, s->other, count + 1)
        && PBW_ZEROS(memory, s->first, range + 1);
}

static void pbwim__end_sorting(pbw_memory *memory, pbwim__sorting *s)
{
    PBW_RELEASE(memory, s->items);
    PBW_RELEASE(memory, s->other);
    PBW_RELEASE(memory, s->first);
}

static int pbwim__compare_owners(const pbwim__facet *x, const pbwim__facet *y)
{
    return x->t != y->t ? (x->t > y->t) - (x->t < y->t) : x->i - y->i;
}

static int pbwim__compare_pairs(const void *a, const void *b)
{
    const pbwim__facet *x = (const pbwim__facet *)a, *y = (const pbwim__facet *)b;
    return x->v[1] != y->v[1] ? (x->v[1] > y->v[1]) - (x->v[1] < y->v[1]) : pbwim__compare_owners(x, y);
}

static int pbwim__compare_triples(const void *a, const void *b)
{
    const pbwim__facet *x = (const pbwim__facet *)a, *y = (const pbwim__facet *)b;
    return x->v[1] != y->v[1] || x->v[2] == y->v[2] ? pbwim__compare_pairs(a, b)
         : (x->v[2] > y->v[2]) - (x->v[2] < y->v[2]);
}

static pbw_status pbwim__count_items(void *arg, size_t from, size_t to)
{
    const pbwim__sorting *s = (const pbwim__sorting *)arg;
    for (; from < to; from++) {
        (void)PBW_ATOMIC_ADD(&s->first.at[s->items.at[from].v[0] + 1], 1);
    }
    return PBW_OK;
}

static pbw_status pbwim__place_items(void *arg, size_t from, size_t to)
{
    const pbwim__sorting *s = (const pbwim__sorting *)arg;
    for (; from < to; from++) {
        const size_t at = PBW_ATOMIC_ADD(&s->first.at[s->items.at[from].v[0]], 1);
        s->other.at[at] = s->items.at[from];
    }
    return PBW_OK;
}

/* Sorts the items of each of these numbers: threads may have placed them in any order. */
static pbw_status pbwim__sort_items(void *arg, size_t from, size_t to)
{
    const pbwim__sorting *s = (const pbwim__sorting *)arg;
    for (; from < to; from++) {
        const size_t begin = from > 0 ? s->first.at[from - 1] : 0, count = s->first.at[from] - begin;
        pbwim__facet *item = s->other.at + begin;
        size_t i, k;
        if (count > 64) {
            qsort(item, count, sizeof *item, s->compare);
            continue;
        }
        for (i = 1; i < count; i++) {
            const pbwim__facet moving = item[i];
            for (k = i; k > 0 && s->compare(&moving, item + k - 1) < 0; k--) {
                item[k] = item[k - 1];
            }
            item[k] = moving;
        }
    }
    return PBW_OK;
}

/* Sorts items.at[0] .. [count - 1] by their first 2 or 3 columns, those of equal numbers by t, then i.  Returns the
   items, NULL if there is no memory. */
static pbwim__facet *pbwim__sort(const pbw_options *options, pbwim__sorting *s, size_t count, int columns)
{
    const size_t range = s->first.count - 1;
    size_t *first = s->first.at, i;
    pbw_status status = pbw_for(options, count, PBWIM__SLICE, pbwim__count_items, s);
    for (i = 0; i < range; i++) {
        first[i + 1] += first[i];
    }
    s->compare = columns == 2 ? pbwim__compare_pairs : pbwim__compare_triples;
    status = status != PBW_OK ? status : pbw_for(options, count, PBWIM__SLICE, pbwim__place_items, s);
    status = status != PBW_OK ? status : pbw_for(options, range, PBWIM__SLICE / 4, pbwim__sort_items, s);
    return status == PBW_OK ? s->other.at : NULL;
}

/* Returns whether t sees the corners of its facet i, in ascending order, counter-clockwise. */
static int pbwim__facet_parity(const pbwim__mesh *m, pbw_index t, int i)
{
    const pbw_index *c = m->corner.at[t];
    const pbw_index a = c[pbwim__opposite[i][0]], b = c[pbwim__opposite[i][1]], d = c[pbwim__opposite[i][2]];
    return ((a < b) + (b < d) + (a < d)) % 2;
}

static void pbwim__invert(pbwim__mesh *m, pbw_index t)
{
    pbw_index *c = m->corner.at[t], *next = m->next.at[t], swap = c[0];
    c[0] = c[1];
    c[1] = swap;
    swap = next[0];
    next[0] = next[1];
    next[1] = swap;
    if (m->patched) {
        pbw_index *patch = m->patch.at[t];
        swap = patch[0];
        patch[0] = patch[1];
        patch[1] = swap;
    }
}

/* ---- neighbours: the facets of tetrahedra, those at one lowest corner sorted by their other corners ---- */

typedef struct pbwim__side {
    uint64_t key;                          /* the facet's other two corners */
    pbw_index facet;                       /* 4 t + i */
    int odd;                               /* how t sees its corners in ascending order */
} pbwim__side;

typedef struct pbwim__linking {
    pbwim__mesh *m;
    PBW_ARRAY(pbwim__side) sides;
    pbwsf__indices last;                   /* per point, where its sides begin; once they are in, where they end */
    pbwsf__indices valence;                /* per point, its tetrahedra */
    PBW_ARRAY(uint64_t) counts;            /* per point, its sides, and 2^32 for each of its tetrahedra */
    size_t flaw;                           /* the first side of a facet that three have, else -1 */
    int mixed, joints;                     /* two tetrahedra are on one side of a facet; there are joints */
} pbwim__linking;

/* Sorts the corners of t, 4 times a corner and its number each.  Returns whether their order is odd. */
static int pbwim__sort_corners(const pbw_index *c, uint64_t sorted[4])
{
    static const int pair[5][2] = { { 0, 1 }, { 2, 3 }, { 0, 2 }, { 1, 3 }, { 1, 2 } };
    int i, odd = 0;
    for (i = 0; i < 4; i++) {
        sorted[i] = (uint64_t)c[i] << 2 | (uint64_t)i;
    }
    for (i = 0; i < 5; i++) {
        uint64_t *x = sorted + pair[i][0], *y = sorted + pair[i][1];
        const uint64_t low = *x < *y ? *x : *y, high = *x < *y ? *y : *x;
        odd ^= low != *x;
        *x = low;
        *y = high;
    }
    return odd;
}

static pbw_status pbwim__count_sides(void *arg, size_t from, size_t to)
{
    const pbwim__linking *k = (const pbwim__linking *)arg;
    const uint64_t one = (uint64_t)1 << 32;
    uint64_t c[4];
    for (; from < to; from++) {
        (void)pbwim__sort_corners(k->m->corner.at[from], c);
        (void)PBW_ATOMIC_ADD(&k->counts.at[c[0] >> 2], one + 3);
        (void)PBW_ATOMIC_ADD(&k->counts.at[c[1] >> 2], one + 1);
        (void)PBW_ATOMIC_ADD(&k->counts.at[c[2] >> 2], one);
        (void)PBW_ATOMIC_ADD(&k->counts.at[c[3] >> 2], one);
    }
    return PBW_OK;
}

static pbw_status pbwim__list_sides(void *arg, size_t from, size_t to)
{
    const pbwim__linking *k = (const pbwim__linking *)arg;
    uint64_t c[4];
    int i;
    for (; from < to; from++) {
        const int odd = pbwim__sort_corners(k->m->corner.at[from], c);
        const size_t first = PBW_ATOMIC_ADD(&k->last.at[c[0] >> 2], 3);
        const size_t second = PBW_ATOMIC_ADD(&k->last.at[c[1] >> 2], 1);
        for (i = 0; i < 4; i++) {                    /* across from corner i of the sorted ones */
            pbwim__side *side = k->sides.at + (i == 0 ? second : first + (size_t)(i - 1));
            side->key = c[i < 2 ? 2 : 1] >> 2 << 32 | c[i < 3 ? 3 : 2] >> 2;
            side->facet = (pbw_index)(4 * from + c[i] % 4);
            side->odd = odd ^ i % 2;
        }
    }
    return PBW_OK;
}

static int pbwim__compare_sides(const void *a, const void *b)
{
    const pbwim__side *x = (const pbwim__side *)a, *y = (const pbwim__side *)b;
    return x->key != y->key ? (x->key > y->key) - (x->key < y->key) : (x->facet > y->facet) - (x->facet < y->facet);
}

/* Sorts the sides of one point: threads may have listed them in any order. */
static void pbwim__sort_sides(pbwim__side *side, size_t count)
{
    size_t i, k;
    if (count > 64) {
        qsort(side, count, sizeof *side, pbwim__compare_sides);
        return;
    }
    for (i = 1; i < count; i++) {
        const pbwim__side moving = side[i];
        for (k = i; k > 0 && (moving.key < side[k - 1].key
                              || (moving.key == side[k - 1].key && moving.facet < side[k - 1].facet)); k--) {
            side[k] = side[k - 1];
        }
        side[k] = moving;
    }
}

/* Links the tetrahedra at each facet of which the lowest corner is one of from .. to - 1. */
static pbw_status pbwim__link_sides(void *arg, size_t from, size_t to)
{
    pbwim__linking *k = (pbwim__linking *)arg;
    pbwim__mesh *m = k->m;
    size_t p, i;
    for (p = from; p < to; p++) {
        const size_t begin = p > 0 ? k->last.at[p - 1] : 0, end = k->last.at[p];
        pbwim__side *side = k->sides.at;
        pbwim__sort_sides(side + begin, end - begin);
        for (i = begin; i < end; i++) {
            const pbw_index f = side[i].facet, g = i + 1 < end && side[i].key == side[i + 1].key ? side[i + 1].facet
                                                                                               : PBW_NONE;
            m->next.at[f / 4][f % 4] = g == PBW_NONE ? PBW_NONE : g / 4;
            if (g == PBW_NONE) {
                continue;
            }
            m->next.at[g / 4][g % 4] = f / 4;
            if (side[i].odd == side[i + 1].odd) {
                PBW_ATOMIC_STORE(&k->mixed, 1);
            }
            if (i + 2 < end && side[i].key == side[i + 2].key) {
                size_t flaw = PBW_ATOMIC_LOAD(&k->flaw);
                while (i < flaw && !PBW_ATOMIC_CAS(&k->flaw, &flaw, i)) {
                }
                return PBW_ERROR_ARGUMENT;
            }
            i++;
        }
    }
    return PBW_OK;
}

/* Links all tetrahedra. */
static pbw_status pbwim__link(pbwim__linking *k)
{
    pbwim__mesh *m = k->m;
    pbw_status status;
    pbw_index sum = 0;
    size_t p;
    if (!PBW_FIT(&m->memory, k->sides, 4 * m->tets + 1) || !PBW_FIT(&m->memory, k->last, m->points + 1)
        || !PBW_FIT(&m->memory, k->valence, m->points + 1) || !PBW_ZEROS(&m->memory, k->counts, m->points)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__count_sides, k);
    for (p = 0; p < m->points; p++) {
        k->valence.at[p] = (pbw_index)(k->counts.at[p] >> 32);
        k->last.at[p] = sum;
        sum += (pbw_index)k->counts.at[p];
    }
    status = status != PBW_OK ? status : pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__list_sides, k);
    status = status != PBW_OK ? status : pbwim__for(m, m->points, PBWIM__SLICE / 4, pbwim__link_sides, k);
    if (status == PBW_ERROR_ARGUMENT) {
        pbwim__set_message(m, "tetrahedra %zu and %zu are at a facet that others have, too",
                           k->sides.at[k->flaw].facet / 4, k->sides.at[k->flaw + 1].facet / 4);
    }
    return status;
}

/* Orients flat tetrahedra as their neighbours are; then all must agree. */
static pbw_status pbwim__check_orientation(pbwim__mesh *m)
{
    size_t t;
    int i, flat;
    for (flat = 1; flat >= 0; flat--) {
        for (t = 0; t < m->tets; t++) {
            if (flat && m->quality.at[t] > 0) {
                continue;
            }
            for (i = 0; i < 4; i++) {
                const pbw_index n = m->next.at[t][i];
                if (n != PBW_NONE && pbwim__facet_parity(m, (pbw_index)t, i)
                                     == pbwim__facet_parity(m, n, pbwim__facet_to(m, n, (pbw_index)t))) {
                    if (!flat) {
                        pbwim__set_message(m, "tetrahedra %zu and %zu overlap", t, n);
                        return PBW_ERROR_ARGUMENT;
                    }
                    if (m->quality.at[n] > 0 || n < t) {
                        pbwim__invert(m, (pbw_index)t);
                        break;
                    }
                }
            }
        }
    }
    return PBW_OK;
}

static void pbwim__fix(pbwim__mesh *m, pbw_index p)
{
    m->mark.at[p] = m->mark.at[p] == PBW_TETS_FROZEN ? PBW_TETS_FROZEN : PBW_TETS_FIXED;
}

/* Fixes the ends of boundary edges that have an angle above the feature angle, or not exactly two facets; with
   borders, of edges between patches.  edge: each boundary facet three times, sorted by edges. */
static void pbwim__fix_features(pbwim__mesh *m, const pbwim__facet *edge, size_t count, double cosine, int borders)
{
    size_t i, k;
    for (i = 0; i < count; i = k) {
        double n[2][3];
        int fixed, pair;
        for (k = i + 1; k < count && memcmp(edge[i].v, edge[k].v, 2 * sizeof(pbw_index)) == 0; k++) {
        }
        pair = k - i == 2;
        fixed = !pair && !borders;
        if (pair && borders) {
            fixed = m->patch.at[edge[i].t][edge[i].i] != m->patch.at[edge[i + 1].t][edge[i + 1].i];
        } else if (pair) {
            pbwim__outward(m, edge[i].t, edge[i].i, n[0]);
            pbwim__outward(m, edge[i + 1].t, edge[i + 1].i, n[1]);
            fixed = !pbwim__turned_less(n[0], n[1], cosine);
        }
        if (fixed) {
            pbwim__fix(m, edge[i].v[0]);
            pbwim__fix(m, edge[i].v[1]);
        }
    }
}

/* Fixes points of several regions, and joints: points at which tetrahedra meet without a facet between. */
static pbw_status pbwim__fix_joints(void *arg, size_t from, size_t to)
{
    pbwim__linking *k = (pbwim__linking *)arg;
    pbwim__mesh *m = k->m;
    pbw_index star[PBWIM__MOST];
    size_t p;
    int i, count;
    for (p = from; p < to; p++) {
        m->joint.at[p] = 0;
        if (k->valence.at[p] > 0) {
            count = pbwim__star_of(m, (pbw_index)p, star);
            for (i = 1; i < count && m->region.at[star[i]] == m->region.at[star[0]]; i++) {
            }
            m->joint.at[p] = (pbw_index)count != k->valence.at[p];
            if (m->joint.at[p] || i < count) {
                m->mark.at[p] = PBW_TETS_FIXED;
            }
            for (i = 0; i < count; i++) {            /* threads have set one of them */
                m->star.at[p] = star[i] > m->star.at[p] ? star[i] : m->star.at[p];
            }
            if (m->joint.at[p]) {
                PBW_ATOMIC_STORE(&k->joints, 1);
            }
        }
    }
    return PBW_OK;
}

/* The star of a joint is that of its last tetrahedron. */
static pbw_status pbwim__set_joint_stars(void *arg, size_t from, size_t to)
{
    const pbwim__mesh *m = ((const pbwim__linking *)arg)->m;
    size_t i;
    for (i = 4 * from; i < 4 * to; i++) {
        const pbw_index p = m->corner.at[i / 4][i % 4];
        if (m->joint.at[p]) {
            pbw_index old = PBW_ATOMIC_LOAD(&m->star.at[p]);
            while (old < i / 4 && !PBW_ATOMIC_CAS(&m->star.at[p], &old, (pbw_index)(i / 4))) {
            }
        }
    }
    return PBW_OK;
}

static pbw_status pbwim__count_boundary(void *arg, size_t from, size_t to)
{
    const pbwim__mesh *m = (const pbwim__mesh *)arg;
    size_t i, count = 0;
    for (i = 4 * from; i < 4 * to; i++) {
        count += *m->corner.at[i / 4] != PBW_NONE && m->next.at[i / 4][i % 4] == PBW_NONE;
    }
    m->tally.at[from / PBWIM__SLICE] = count;
    return PBW_OK;
}

typedef struct pbwim__bounding {           /* a list of the boundary's facets */
    pbwim__mesh *m;
    pbw_index *triangles;                  /* outward, or NULL */
    pbwim__facet *edges, *facets;          /* three for each triangle; or the facets */
} pbwim__bounding;

static pbw_status pbwim__list_boundary(void *arg, size_t from, size_t to)
{
    const pbwim__bounding *b = (const pbwim__bounding *)arg;
    const pbwim__mesh *m = b->m;
    size_t j, count = m->tally.at[from / PBWIM__SLICE];
    int k;
    for (j = 4 * from; j < 4 * to; j++) {
        const pbw_index *c = m->corner.at[j / 4];
        const int i = (int)(j % 4), *o = pbwim__opposite[i];
        if (*c == PBW_NONE || m->next.at[j / 4][i] != PBW_NONE) {
            continue;
        }
        for (k = 0; k < 3 && b->triangles != NULL; k++) {
            pbwim__facet *edge = b->edges + 3 * count + k;
            const pbw_index x = c[o[k]], y = c[o[(k + 1) % 3]];
            b->triangles[3 * count + (size_t)(2 - k)] = x;
            edge->v[0] = x < y ? x : y;
            edge->v[1] = x < y ? y : x;
            edge->t = (pbw_index)(j / 4);
            edge->i = i;
        }
        if (b->triangles == NULL) {
            b->facets[count] = pbwim__facet_of(m, (pbw_index)(j / 4), i);
        }
        count++;
    }
    return PBW_OK;
}

static void pbwim__to_surface(void *user, double point[3])
{
    double place[3];
    if (pbw_surface_closest((const pbw_surface *)user, point, HUGE_VAL, place) != PBW_NONE) {
        memcpy(point, place, sizeof place);
    }
}

/* Copies the patches of facets inside to their other sides, and fixes their corners. */
static void pbwim__fix_patches(pbwim__mesh *m)
{
    size_t t;
    int i, k;
    for (t = 0; t < m->tets && m->patched; t++) {
        for (i = 0; i < 4; i++) {
            const pbw_index n = m->next.at[t][i], patch = m->patch.at[t][i];
            if (n != PBW_NONE && patch != PBW_NONE) {
                m->patch.at[n][pbwim__facet_to(m, n, (pbw_index)t)] = patch;
                for (k = 0; k < 3; k++) {
                    pbwim__fix(m, m->corner.at[t][pbwim__opposite[i][k]]);
                }
            }
        }
    }
}

/* Lists the edges to keep that the mesh has, and fixes their ends. */
static pbw_status pbwim__load_edges(pbwim__mesh *m, const pbw_tets *in)
{
    pbwim__kept_edge *e;
    unsigned char *found;
    pbwsf__flags marks = { NULL, 0, 0 };
    size_t i;
    if (in->edge_count == 0) {
        return PBW_OK;
    }
    if (!pbwim__reserve_edges(m, in->edge_count) || !PBW_FIT(&m->memory, marks, in->edge_count)) {
        return PBW_ERROR_MEMORY;
    }
    found = marks.at;
    memset(found, 0, in->edge_count);
    for (i = 0; i < in->edge_count; i++) {
        const pbw_index a = in->edges[2 * i], b = in->edges[2 * i + 1];
        if (a < m->points && b < m->points && a != b && !pbwim__is_kept(m, a, b)) {
            pbwim__keep_edge(m, a, b, (pbw_index)i);
        }
    }
    for (i = 0; i < 6 * m->tets; i++) {
        const pbw_index *c = m->corner.at[i / 6];
        e = pbwim__find_edge(m, c[pbwim__edge[i % 6][0]], c[pbwim__edge[i % 6][1]]);
        if (e->a != PBW_NONE) {
            found[e->origin] = 1;
            pbwim__fix(m, e->a);
            pbwim__fix(m, e->b);
        }
    }
    for (e = m->edge.at, i = m->edge.capacity; i-- > 0; e++) {
        e->origin = e->a != PBW_NONE && found[e->origin] ? e->origin : PBW_NONE;
    }
    PBW_RELEASE(&m->memory, marks);
    return PBW_OK;
}

/* Marks the boundary's points and builds its surface. */
static pbw_status pbwim__set_marks(pbwim__linking *k, const pbw_tets *in, double cosine, pbwim__sorting *sorting)
{
    pbwim__mesh *m = k->m;
    pbwim__bounding b = { m, NULL, NULL, NULL };
    pbwim__facet *edges;
    pbw_options inner;
    size_t facets, i;
    pbw_status status = pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__count_boundary, m);
    if (status != PBW_OK) {
        return status;
    }
    facets = pbwim__sum_up(m->tally.at, pbwim__slices(m->tets));
    if (!PBW_FIT(&m->memory, m->facets, 3 * facets + 1)
        || !pbwim__begin_sorting(&m->memory, sorting, 3 * facets, m->points)) {
        return PBW_ERROR_MEMORY;
    }
    b.triangles = m->facets.at;
    b.edges = sorting->items.at;
    status = pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__list_boundary, &b);
    if (status != PBW_OK) {
        return status;
    }
    for (i = 0; i < 3 * facets; i++) {
        unsigned char *mark = m->mark.at + b.triangles[i];
        *mark = *mark == PBW_TETS_FOUND ? PBW_TETS_SLIDES : *mark;
    }
    inner = pbwim__inner_options(m->options, &m->memory);
    edges = pbwim__sort(&inner, sorting, 3 * facets, 2);
    if (edges == NULL) {
        return PBW_ERROR_MEMORY;
    }
    pbwim__fix_features(m, edges, 3 * facets, cosine, 0);
    status = pbwim__for(m, m->points, PBWIM__SLICE / 4, pbwim__fix_joints, k);
    if (status == PBW_OK && k->joints) {
        status = pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__set_joint_stars, k);
    }
    if (status != PBW_OK) {
        return status;
    }
    for (i = 0; in->marks != NULL && i < m->points; i++) {
        const unsigned char mark = in->marks[i];
        if (mark == PBW_TETS_FIXED || mark == PBW_TETS_FROZEN
            || (mark == PBW_TETS_SLIDES && m->mark.at[i] != PBW_TETS_FOUND)) {
            m->mark.at[i] = mark;
        }
    }
    if (m->patched) {
        pbwim__fix_features(m, edges, 3 * facets, cosine, 1);
        pbwim__fix_patches(m);
    }
    status = pbwim__load_edges(m, in);
    if (status == PBW_OK && m->project == NULL) {
        inner = pbwim__inner_options(m->options, &m->memory);
        m->project = pbwim__to_surface;
        m->project_user = &m->surface;
        status = pbw_surface_create(in->points, in->point_count, m->facets.at, facets, &inner,
                                    &m->surface);
        m->memory.used += pbwsf__bytes(&m->surface);
    }
    return status;
}

/* Neighbours; then marks. */
static pbw_status pbwim__connect(pbwim__mesh *m, const pbw_tets *in, double cosine)
{
    pbwim__sorting sorting;
    pbwim__linking k;
    pbw_status status;
    memset(&sorting, 0, sizeof sorting);
    memset(&k, 0, sizeof k);
    k.m = m;
    k.flaw = (size_t)-1;
    status = pbwim__link(&k);
    if (status == PBW_OK && k.mixed) {
        status = pbwim__progress(m, 0) ? PBW_CANCELLED : pbwim__check_orientation(m);
    }
    PBW_RELEASE(&m->memory, k.sides);
    PBW_RELEASE(&m->memory, k.last);
    PBW_RELEASE(&m->memory, k.counts);
    status = status != PBW_OK ? status : pbwim__set_marks(&k, in, cosine, &sorting);
    PBW_RELEASE(&m->memory, k.valence);
    pbwim__end_sorting(&m->memory, &sorting);
    return status;
}

typedef struct pbwim__loading {
    pbwim__mesh *m;
    const pbw_tets *in;
    size_t turned, flaw;                   /* tetrahedra; the first that is wrong, else -1 */
} pbwim__loading;

/* Returns the first corner of a tetrahedron of the input that is out of range or twice there, or 4. */
static int pbwim__wrong_corner(const pbw_tets *in, size_t t)
{
    const pbw_index *c = in->corners + 4 * t;
    int i;
    for (i = 0; i < 4 && c[i] < in->point_count && c[i] != c[(i + 1) % 4] && c[i] != c[(i + 2) % 4]; i++) {
    }
    return i;
}

static pbw_status pbwim__load_points(void *arg, size_t from, size_t to)
{
    const pbwim__loading *load = (const pbwim__loading *)arg;
    pbwim__mesh *m = load->m;
    size_t i;
    int k;
    for (i = from; i < to; i++) {
        for (k = 0; k < 3; k++) {
            m->x.at[i][k] = load->in->points[3 * i + (size_t)k];
            if (!(fabs(m->x.at[i][k]) <= 1e300)) {
                return PBW_ERROR_NOT_FINITE;
            }
        }
        m->star.at[i] = PBW_NONE;
        m->touched.at[i] = 1;
        m->failed.at[i] = 0;
        m->mark.at[i] = PBW_TETS_FOUND;
        m->original.at[i] = (pbw_index)i;
    }
    return PBW_OK;
}

/* Tetrahedra of the input, made positive. */
static pbw_status pbwim__load_tets(void *arg, size_t from, size_t to)
{
    pbwim__loading *load = (pbwim__loading *)arg;
    const pbw_tets *in = load->in;
    pbwim__mesh *m = load->m;
    size_t t, turned = 0;
    int i, sign;
    for (t = from; t < to; t++) {
        pbw_index *c = m->corner.at[t];
        if (pbwim__wrong_corner(in, t) < 4) {
            size_t flaw = PBW_ATOMIC_LOAD(&load->flaw);
            while (t < flaw && !PBW_ATOMIC_CAS(&load->flaw, &flaw, t)) {
            }
            return PBW_ERROR_ARGUMENT;
        }
        memcpy(c, in->corners + 4 * t, 4 * sizeof *c);
        if (m->patched) {
            memcpy(m->patch.at[t], in->patches + 4 * t, 4 * sizeof *c);
        }
        for (i = 0; i < 4; i++) {
            PBW_ATOMIC_STORE(&m->star.at[c[i]], (pbw_index)t);
            m->next.at[t][i] = PBW_NONE;
        }
        sign = pbwim__sign_of(m, c);
        if (sign < 0) {
            pbwim__invert(m, (pbw_index)t);
            turned++;
        }
        m->quality.at[t] = sign == 0 ? 0 : fmax(pbwim__sine_of(m, c), 1e-300);
        m->region.at[t] = in->regions != NULL ? in->regions[t] : 0;
        m->tried.at[t][0] = m->tried.at[t][1] = m->seen.at[t] = 0;
    }
    (void)PBW_ATOMIC_ADD(&load->turned, turned);
    return PBW_OK;
}

static pbw_status pbwim__load(pbwim__mesh *m, const pbw_tets *in)
{
    pbwim__loading load = { m, in, 0, (size_t)-1 };
    pbw_status status;
    if (in->tet_count >= PBW_NONE / 4 || in->point_count >= PBW_NONE) {
        return PBW_ERROR_TOO_LARGE;
    }
    if (!pbwim__resize_points(m, in->point_count + in->point_count / 16 + 256)
        || !PBW_FIT(&m->memory, m->joint, in->point_count + 1)
        || !pbwim__resize_tets(m, in->tet_count + in->tet_count / 16 + 4 * PBWIM__MOST)) {
        return PBW_ERROR_MEMORY;
    }
    m->points = in->point_count;
    m->tets = in->tet_count;
    m->free = PBW_NONE;
    m->clock = 1;
    status = pbwim__for(m, m->points, PBWIM__SLICE, pbwim__load_points, &load);
    status = status != PBW_OK ? status : pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__load_tets, &load);
    m->report->turned = load.turned;
    if (status == PBW_ERROR_ARGUMENT) {
        pbwim__set_message(m, "tetrahedron %zu has a corner %zu that is out of range or twice there", load.flaw,
                           in->corners[4 * load.flaw + (size_t)pbwim__wrong_corner(in, load.flaw)]);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>smoothers    Rounds that move all points.
   In: a mesh with marks.  Out: the mesh with other places of points.
   A point moves to the aim of the smoother, or half or a quarter as far, if all of its
   tetrahedra are positive there, by exact signs, and none of them is below both the target and the worst before.
   Points of one colour have no tetrahedron in common, so threads may move them at once; colours are processed one
   after the other.  Moves change neither the tetrahedra nor the colours: the answer does not depend on threads.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWIM__COLOURS = 64, PBWIM__GRAIN = 256 };      /* points beyond the last colour stay */

typedef struct pbwim__smoothing {
    pbwim__mesh *m;
    pbw_smoother smoother;
    pbwsf__indices stars;                  /* tetrahedra of point p: from first[p] to first[p + 1] */
    pbwsf__counts first;
    pbwsf__indices order;                  /* points by colour */
    pbwsf__flags moved;                    /* per point: 1 it has moved; before, its colour */
    size_t begin[PBWIM__COLOURS + 1];      /* of each colour in `order` */
    size_t at;                             /* where the colour in work begins */
} pbwim__smoothing;

/* Adds the contribution of one simplex at corner p to the aim: weighted places relative to p, and the weight. */
static void pbwim__add_weighted(double sum[4], const double place[3], double weight)
{
    int k;
    for (k = 0; k < 3; k++) {
        sum[k] += weight * place[k];
    }
    sum[3] += weight;
}

/* Adds the positive tetrahedron of 0 and u[0..2]: its circumcentre, or the piece of the Voronoi cell of 0 in it, made
   of six signed tetrahedra of 0, the middle of an edge, the circumcentre of a facet, and the circumcentre. */
static void pbwim__aim_inside(pbw_smoother smoother, double u[3][3], double sum[4])
{
    double n[3][3], centre[3] = { 0, 0, 0 }, volume, square[3];
    int i, j, k;
    for (i = 0; i < 3; i++) {
        pbwsf__cross(u[(i + 1) % 3], u[(i + 2) % 3], n[i]);
        square[i] = pbwsf__dot(u[i], u[i]);
    }
    volume = pbwsf__dot(n[0], u[0]);
    for (k = 0; k < 3; k++) {
        centre[k] = (square[0] * n[0][k] + square[1] * n[1][k] + square[2] * n[2][k]) / (2 * volume);
    }
    if (smoother == PBW_SMOOTHER_ODT) {
        pbwim__add_weighted(sum, centre, volume);
        return;
    }
    for (i = 0; i < 3; i++) {                        /* the facet of 0, u[i], u[j], with normal n[i + 2] */
        const double *a = u[i], *b = u[(i + 1) % 3], *normal = n[(i + 2) % 3];
        const double area2 = 2 * pbwsf__dot(normal, normal), ab = pbwsf__dot(a, b);
        const double s = (square[i] - ab) * square[(i + 1) % 3] / area2;
        const double t = (square[(i + 1) % 3] - ab) * square[i] / area2;
        double flat[3], place[3], across[3];
        for (k = 0; k < 3; k++) {
            flat[k] = s * a[k] + t * b[k];
        }
        pbwsf__cross(flat, centre, across);
        for (j = 0; j < 2; j++) {
            const double *edge = j == 0 ? a : b;
            for (k = 0; k < 3; k++) {
                place[k] = (edge[k] / 2 + flat[k] + centre[k]) / 4;
            }
            pbwim__add_weighted(sum, place, (j == 0 ? 0.5 : -0.5) * pbwsf__dot(edge, across));
        }
    }
}

/* Adds the triangle 0, a, b of the boundary in the same way. */
static void pbwim__aim_on(pbw_smoother smoother, const double a[3], const double b[3], double sum[4])
{
    double normal[3], flat[3], across[3], place[3];
    const double aa = pbwsf__dot(a, a), bb = pbwsf__dot(b, b), ab = pbwsf__dot(a, b);
    double area2;
    int j, k;
    pbwsf__cross(a, b, normal);
    area2 = 2 * pbwsf__dot(normal, normal);
    for (k = 0; k < 3; k++) {
        flat[k] = ((aa - ab) * bb * a[k] + (bb - ab) * aa * b[k]) / area2;
    }
    if (smoother == PBW_SMOOTHER_ODT) {
        pbwim__add_weighted(sum, flat, sqrt(area2));
        return;
    }
    for (j = 0; j < 2; j++) {
        const double *edge = j == 0 ? a : b;
        for (k = 0; k < 3; k++) {
            place[k] = (edge[k] / 2 + flat[k]) / 3;
        }
        pbwsf__cross(edge, flat, across);
        pbwim__add_weighted(sum, place, (j == 0 ? 1 : -1) * pbwsf__dot(across, normal));
    }
}

/* Adds the corners of a simplex, each once: `seen` has those that are in. */
static void pbwim__aim_mean(const pbw_index *corner, int corners, double u[3][3], pbw_index *seen, double sum[4])
{
    int i, k, count = (int)sum[3];
    for (i = 0; i < corners; i++) {
        for (k = 0; k < count && seen[k] != corner[i]; k++) {
        }
        if (k == count) {
            seen[count++] = corner[i];
            pbwim__add_weighted(sum, u[i], 1);
        }
    }
}

/* Computes the aim of the smoother relative to p.  Returns 0 if there is none. */
static int pbwim__aim(const pbwim__smoothing *s, pbw_index p, const pbw_index *star, int count, double aim[3])
{
    const pbwim__mesh *m = s->m;
    const int slides = m->mark.at[p] == PBW_TETS_SLIDES;
    pbw_index seen[3 * PBWIM__MOST];
    double sum[4] = { 0, 0, 0, 0 };
    int i, j, k;
    for (i = 0; i < count; i++) {
        const pbw_index *c = m->corner.at[star[i]];
        const int at = pbwim__corner_of(m, star[i], p);
        for (j = 0; j < (slides ? 3 : 1); j++) {     /* each of its facets at p, or all of it */
            const int *o = pbwim__opposite[at];
            const int out = slides ? o[j] : 4, corners = slides ? 2 : 3;
            pbw_index corner[3];
            double u[3][3];
            if (slides && m->next.at[star[i]][out] != PBW_NONE) {
                continue;
            }
            for (k = 0; k < corners; k++) {
                corner[k] = c[slides ? o[(j + 1 + k) % 3] : o[k]];
                pbwsf__minus(m->x.at[corner[k]], m->x.at[p], u[k]);
            }
            if (s->smoother == PBW_SMOOTHER_LAPLACIAN) {
                pbwim__aim_mean(corner, corners, u, seen, sum);
            } else if (slides) {
                pbwim__aim_on(s->smoother, u[0], u[1], sum);
            } else {
                pbwim__aim_inside(s->smoother, u, sum);
            }
        }
    }
    for (k = 0; k < 3; k++) {
        aim[k] = sum[k] / sum[3];
    }
    return fabs(aim[0]) + fabs(aim[1]) + fabs(aim[2]) <= 1e300 && fabs(sum[3]) > 0;
}

/* Moves p.  Returns whether it did. */
static int pbwim__move(const pbwim__smoothing *s, pbw_index p)
{
    const pbwim__mesh *m = s->m;
    const size_t *first = s->first.at + p;
    const pbw_index *star = s->stars.at + first[0];
    const int count = (int)(first[1] - first[0]);
    double aim[3], before[3], worst = m->target, quality[PBWIM__MOST];
    int i, k, tries;
    for (i = 0; i < count; i++) {
        worst = fmin(worst, m->quality.at[star[i]]);
    }
    if (!pbwim__aim(s, p, star, count, aim)) {
        return 0;
    }
    memcpy(before, m->x.at[p], sizeof before);
    for (tries = 0; tries < 3; tries++) {
        double *x = m->x.at[p], step = tries == 0 ? 1 : tries == 1 ? 0.5 : 0.25;
        for (k = 0; k < 3; k++) {
            x[k] = before[k] + step * aim[k];
        }
        if (m->mark.at[p] == PBW_TETS_SLIDES) {
            m->project(m->project_user, x);
        }
        for (i = 0; i < count; i++) {
            quality[i] = pbwim__sine_of(m, m->corner.at[star[i]]);
            if (!(quality[i] >= worst) || pbwim__sign_of(m, m->corner.at[star[i]]) <= 0) {
                break;
            }
        }
        if (i == count) {
            for (i = 0; i < count; i++) {
                m->quality.at[star[i]] = quality[i];
            }
            return memcmp(x, before, sizeof before) != 0;
        }
    }
    memcpy(m->x.at[p], before, sizeof before);
    return 0;
}

static pbw_status pbwim__move_range(void *arg, size_t from, size_t to)
{
    const pbwim__smoothing *s = (const pbwim__smoothing *)arg;
    size_t i;
    for (i = s->at + from; i < s->at + to; i++) {
        const pbw_index p = s->order.at[i];
        s->moved.at[p] = (unsigned char)pbwim__move(s, p);
    }
    return PBW_OK;
}

/* Returns the lowest colour that no neighbour of p has so far; PBWIM__COLOURS if there is none or p does not move. */
static int pbwim__colour(const pbwim__smoothing *s, pbw_index p)
{
    const size_t *first = s->first.at;
    const unsigned char *colour = s->moved.at;
    char used[PBWIM__COLOURS + 1] = { 0 };
    size_t i;
    int k;
    if (s->m->mark.at[p] >= PBW_TETS_FIXED || first[p + 1] - first[p] > PBWIM__MOST
        || first[p + 1] == first[p]) {
        return PBWIM__COLOURS;
    }
    for (i = first[p]; i < first[p + 1]; i++) {
        const pbw_index *c = s->m->corner.at[s->stars.at[i]];
        for (k = 0; k < 4; k++) {
            used[c[k] < p ? (int)colour[c[k]] : (int)PBWIM__COLOURS] = 1;
        }
    }
    for (k = 0; k < PBWIM__COLOURS && used[k]; k++) {
    }
    return k;
}

/* Stars, colours and the order of points by them.  Returns 0 if there is no memory. */
static int pbwim__set_colours(pbwim__smoothing *s)
{
    pbwim__mesh *m = s->m;
    size_t *first, t, p, sum[PBWIM__COLOURS + 2] = { 0 };
    unsigned char *colour;
    pbw_index *order;
    int k;
    if (!PBW_FIT(&m->memory, s->stars, 4 * m->tets + 1)
        || !PBW_FIT(&m->memory, s->first, m->points + 2)
        || !PBW_FIT(&m->memory, s->order, m->points + 1)
        || !PBW_FIT(&m->memory, s->moved, m->points + 1)) {
        return 0;
    }
    first = s->first.at;
    colour = s->moved.at;
    order = s->order.at;
    memset(first, 0, s->first.capacity * sizeof *first);
    for (t = 0; t < 4 * m->tets; t++) {
        if (*m->corner.at[t / 4] != PBW_NONE) {
            first[m->corner.at[t / 4][t % 4] + 2]++;
        }
    }
    for (p = 2; p < m->points + 2; p++) {
        first[p] += first[p - 1];
    }
    for (t = 0; t < 4 * m->tets; t++) {
        if (*m->corner.at[t / 4] != PBW_NONE) {
            s->stars.at[first[m->corner.at[t / 4][t % 4] + 1]++] = (pbw_index)(t / 4);
        }
    }
    for (p = 0; p < m->points; p++) {
        colour[p] = (unsigned char)pbwim__colour(s, (pbw_index)p);
        sum[colour[p] + 1]++;
    }
    for (k = 0; k <= PBWIM__COLOURS; k++) {
        sum[k + 1] += sum[k];
        s->begin[k] = sum[k];
    }
    for (p = 0; p < m->points; p++) {
        order[sum[colour[p]]++] = (pbw_index)p;
    }
    return 1;
}

/* Returns whether the time of the call is over. */
static int pbwim__is_late(const pbwim__mesh *m)
{
    return m->deadline > 0 && (double)clock() / CLOCKS_PER_SEC > m->deadline;
}

/* Rounds over all colours, from `done` of the work to the next. */
static pbw_status pbwim__rounds(pbwim__smoothing *s, int rounds, double done)
{
    pbwim__mesh *m = s->m;
    const pbw_options inner = pbwim__inner_options(m->options, &m->memory);
    pbw_status status = PBW_OK;
    size_t moves = 1, p;
    int round, k;
    for (round = 0; round < rounds && moves > 0 && status == PBW_OK; round++) {
        memset(s->moved.at, 0, s->moved.capacity * sizeof *s->moved.at);
        for (k = 0; k < PBWIM__COLOURS && s->begin[k] < s->begin[PBWIM__COLOURS] && status == PBW_OK; k++) {
            if (pbwim__progress(m, done * round / rounds)) {
                return PBW_CANCELLED;
            }
            if (pbwim__is_late(m)) {
                return PBW_OK;
            }
            s->at = s->begin[k];
            status = pbw_for(&inner, s->begin[k + 1] - s->at, PBWIM__GRAIN, pbwim__move_range, s);
        }
        for (p = moves = 0; p < m->points; p++) {
            moves += s->moved.at[p];
        }
        m->report->moves += moves;
        m->report->rounds++;
    }
    return status;
}

/* Smooths before the passes.  Progress goes to a half, where passes follow. */
static pbw_status pbwim__smooth_all(pbwim__mesh *m, const pbw_improve_options *how)
{
    pbwim__smoothing s;
    pbw_status status = PBW_ERROR_MEMORY;
    memset(&s, 0, sizeof s);
    s.m = m;
    s.smoother = how->smoother;
    if (pbwim__set_colours(&s)) {
        status = pbwim__rounds(&s, how->rounds, how->passes < 0 ? 1 : 0.5);
    }
    memset(m->tried.at, 0, m->tets * sizeof *m->tried.at);               /* all has moved since passes for sizes */
    memset(m->failed.at, 0, m->points * sizeof *m->failed.at);
    PBW_RELEASE(&m->memory, s.stars);
    PBW_RELEASE(&m->memory, s.first);
    PBW_RELEASE(&m->memory, s.order);
    PBW_RELEASE(&m->memory, s.moved);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>passes       Tetrahedra below the target, in blocks on all threads, in each the worst first.
   In: a mesh.  Out: the mesh, better.

   1. The queue of a pass has all tetrahedra below the target, but for those on which all operations failed and no
      corner has changed since.  Contraction and insertion are used in each fourth pass, and after a pass that changed
      little.
   2. Points have places along two Hilbert curves: one through the points, one through the points turned.  A new
      point has the places of a point near it.  A block is the points with places in a range along one curve.
   3. The zone of a tetrahedron is all that improving it reads: the tetrahedra at its corners, and for boundary edges
      those at one end of the ring.  A pass has rounds.  In a round each block is a task for any thread: it takes the
      tetrahedra of the queue that are in its block with all points of their zones, worst first.  The others wait for
      the next round, which has other and larger blocks; the last one has all points in one block.
   4. A task is a copy of pbwim__mesh with free slots, free points and counters of its own.  Where these run out, its
      tetrahedra wait, too.  When all tasks of a round have ended, they are merged in order.
   5. The caller is asked whether to go on while no task runs, so that each pauses after so much work, which is
      counted in sines: a round is done in legs.
   No task reads what another one changes.  A tetrahedron that a task changes has all corners in the task's block, and
   a task reads only tetrahedra with a corner in its block, and of these only links through facets that have one.  A
   tetrahedron across a facet of a zone has three corners in it: of this tetrahedron, only the link through that facet
   changes, and no other block has these three corners.  Blocks, tasks and slots depend on the mesh only, so the
   answer does not depend on threads.
   ------------------------------------------------------------------------------------------------------ */
enum {
    PBWIM__BLOCKS = 256,                   /* at most */
    PBWIM__BLOCK_POINTS = 1024,            /* at least: in smaller blocks most zones have points of others */
    PBWIM__BLOCK_ITEMS = 16,               /* of the queue, a block, at least */
    PBWIM__ITEM_EFFORT = 128,              /* of looking at the rings and the zone of a tetrahedron, in sines */
    PBWIM__LEG = 200000                    /* effort after which a task pauses: some 20 ms */
};

typedef struct pbwim__task {
    pbwim__mesh m;                         /* free points: m.points .. point_end - 1 */
    pbw_improve_report report;
    size_t point_end;
    pbwim__item *item;                     /* the tetrahedra to improve; in the end, those that wait */
    size_t count, changes;
    size_t next, waiting;                  /* of `item`: the next to look at; how many before it wait */
    int all, curve;                        /* of places: curve -1 = one block of all points */
    pbw_index first, last;                 /* the block's places: first .. last - 1 */
    size_t turn;                           /* the task that is run in place of this one: the longest come first */
} pbwim__task;

static int pbwim__compare_items(const void *a, const void *b)
{
    const pbwim__item *x = (const pbwim__item *)a, *y = (const pbwim__item *)b;
    return x->quality > y->quality ? 1 : x->quality < y->quality ? -1 : (x->t > y->t) - (x->t < y->t);
}

static int pbwim__is_bad(const pbwim__mesh *m, pbw_index t)
{
    return *m->corner.at[t] != PBW_NONE && m->quality.at[t] < m->target;
}

static int pbwim__is_due(const pbwim__mesh *m, pbw_index t, int all)
{
    const pbw_index *c = m->corner.at[t], *touched = m->touched.at;
    const pbw_index tried = m->tried.at[t][all != 0];
    return touched[c[0]] > tried || touched[c[1]] > tried || touched[c[2]] > tried || touched[c[3]] > tried;
}

/* Makes one tetrahedron better, or replaces it.  Returns whether it did. */
static int pbwim__improve_tet(pbwim__mesh *m, pbw_index t, int all)
{
    int k, moved = 0;
    if (pbwim__remove_edge(m, t) || pbwim__peel(m, t)) {
        return 1;
    }
    for (k = 0; k < 4 && m->quality.at[t] < m->target; k++) {
        moved += pbwim__smooth(m, m->corner.at[t][k]);
    }
    if (!moved && (pbwim__flip(m, t)
                   || (all && (pbwim__contract(m, t) || pbwim__rejoin(m, t) || pbwim__split(m, t))))) {
        return 1;
    }
    if (!moved) {
        m->tried.at[t][0] = m->clock;
        m->tried.at[t][1] = all ? m->clock : m->tried.at[t][1];
    }
    return moved > 0;
}

/* Returns whether a corner of t is active.  Points that were inserted after the flags were set are. */
static int pbwim__is_active(const pbwim__mesh *m, pbw_index t)
{
    const unsigned char *active = m->active.at;
    int k;
    for (k = 0; k < 4; k++) {
        const pbw_index p = m->corner.at[t][k];
        if (p >= m->active.count || active[p]) {
            return 1;
        }
    }
    return 0;
}

typedef struct pbwim__marking {
    const pbwim__mesh *m;
    unsigned char ring;
} pbwim__marking;

/* Flags corners: of bad tetrahedra as 1; then of those that have such a corner, others as 2. */
static pbw_status pbwim__flag_corners(void *arg, size_t from, size_t to)
{
    const pbwim__mesh *m = ((const pbwim__marking *)arg)->m;
    const unsigned char ring = ((const pbwim__marking *)arg)->ring;
    unsigned char *active = m->active.at;
    size_t t;
    int k, inside;
    for (t = from; t < to; t++) {
        const pbw_index *c = m->corner.at[t];
        inside = ring == 1 && pbwim__is_bad(m, (pbw_index)t);
        for (k = 0; k < 4 && ring == 2 && *c != PBW_NONE; k++) {
            inside |= PBW_ATOMIC_LOAD(&active[c[k]]) == 1;
        }
        for (k = 0; k < 4 && inside; k++) {
            if (PBW_ATOMIC_LOAD(&active[c[k]]) == 0) {
                PBW_ATOMIC_STORE(&active[c[k]], ring);
            }
        }
    }
    return PBW_OK;
}

/* Flags the corners of bad tetrahedra and of their neighbours as active. */
static pbw_status pbwim__flag_active(pbwim__mesh *m)
{
    pbwim__marking marking = { m, 1 };
    pbw_status status;
    if (!PBW_FIT(&m->memory, m->active, m->points)) {
        return PBW_ERROR_MEMORY;
    }
    memset(m->active.at, 0, m->points);
    status = pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__flag_corners, &marking);
    marking.ring = 2;
    status = status != PBW_OK ? status : pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__flag_corners, &marking);
    m->active.count = m->points;
    return status;
}

/* ---- the queue ---- */

typedef struct pbwim__survey {             /* of all tetrahedra: how many are bad and due, and what lacks */
    const pbwim__mesh *m;
    pbwim__item *item;                     /* NULL: they are counted */
    int all;
} pbwim__survey;

static pbw_status pbwim__survey_slice(void *arg, size_t from, size_t to)
{
    const pbwim__survey *s = (const pbwim__survey *)arg;
    const pbwim__mesh *m = s->m;
    size_t t, count = s->item != NULL ? m->tally.at[from / PBWIM__SLICE] : 0;
    for (t = from; t < to; t++) {
        if (pbwim__is_bad(m, (pbw_index)t) && pbwim__is_due(m, (pbw_index)t, s->all)
            && pbwim__is_active(m, (pbw_index)t)) {
            if (s->item != NULL) {
                s->item[count].quality = m->quality.at[t];
                s->item[count].t = (pbw_index)t;
            }
            count++;
        }
    }
    m->tally.at[from / PBWIM__SLICE] = s->item != NULL ? m->tally.at[from / PBWIM__SLICE] : count;
    return PBW_OK;
}

static pbw_status pbwim__fill_queue(pbwim__mesh *m, int all)
{
    pbwim__survey survey = { m, NULL, all };
    pbw_status status = pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__survey_slice, &survey);
    m->queue.count = 0;
    if (status == PBW_OK) {
        const size_t count = pbwim__sum_up(m->tally.at, pbwim__slices(m->tets));
        if (!PBW_RESERVE(&m->memory, m->queue, count + 1)) {
            return PBW_ERROR_MEMORY;
        }
        survey.item = m->queue.at;
        status = count == 0 ? PBW_OK : pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__survey_slice, &survey);
        m->queue.count = count;
    }
    return status;
}

/* ---- places ---- */

typedef struct pbwim__placing {
    pbwim__mesh *m;
    pbwsf__vectors turned;
    pbwsf__indices order;
    int curve;
} pbwim__placing;

/* Turns points: the planes that the first curve seldom crosses are others than those of the second. */
static pbw_status pbwim__turn_points(void *arg, size_t from, size_t to)
{
    const pbwim__placing *w = (const pbwim__placing *)arg;
    size_t p;
    for (p = from; p < to; p++) {
        const double *x = w->m->x.at[p];
        double *y = w->turned.at[p];
        y[0] = 0.64 * x[0] + 0.48 * x[1] + 0.6 * x[2];
        y[1] = 0.8 * x[1] - 0.6 * x[0];
        y[2] = 0.8 * x[2] - 0.48 * x[0] - 0.36 * x[1];
    }
    return PBW_OK;
}

static pbw_status pbwim__set_places(void *arg, size_t from, size_t to)
{
    const pbwim__placing *w = (const pbwim__placing *)arg;
    for (; from < to; from++) {
        w->m->place.at[w->order.at[from]][w->curve] = (pbw_index)from;
    }
    return PBW_OK;
}

/* Gives all points their places along both curves. */
static pbw_status pbwim__place_points(pbwim__mesh *m)
{
    pbwim__placing w;
    pbw_status status = PBW_ERROR_MEMORY;
    memset(&w, 0, sizeof w);
    w.m = m;
    if (PBW_FIT(&m->memory, m->place, m->mark.capacity) && PBW_FIT(&m->memory, w.turned, m->points)
        && PBW_FIT(&m->memory, w.order, m->points)) {
        status = pbwim__for(m, m->points, PBWIM__SLICE, pbwim__turn_points, &w);
    }
    for (w.curve = 0; w.curve < 2 && status == PBW_OK; w.curve++) {
        pbw_options inner = pbwim__inner_options(m->options, &m->memory);
        const double *x = w.curve == 0 ? m->x.at[0] : w.turned.at[0];
        inner.stride = 0;
        status = pbw_order(3, x, m->points, &inner, w.order.at);
        status = status != PBW_OK ? status : pbwim__for(m, m->points, PBWIM__SLICE, pbwim__set_places, &w);
    }
    m->placed = status == PBW_OK ? m->points : 0;
    PBW_RELEASE(&m->memory, w.turned);
    PBW_RELEASE(&m->memory, w.order);
    return status;
}

/* Returns whether a point is in the block of the task. */
PBW_INLINE int pbwim__has_point(const pbwim__task *task, pbw_index p)
{
    return task->curve < 0 || task->m.place.at[p][task->curve] - task->first < task->last - task->first;
}

/* Returns whether the corners of t are. */
static int pbwim__has_corners(const pbwim__task *task, pbw_index t)
{
    const pbw_index *c = task->m.corner.at[t];
    return pbwim__has_point(task, c[0]) && pbwim__has_point(task, c[1]) && pbwim__has_point(task, c[2])
        && pbwim__has_point(task, c[3]);
}

/* Returns whether all points of the zone of t are, which has its corners there. */
static int pbwim__has_zone(const pbwim__task *task, pbw_index t)
{
    const pbwim__mesh *m = &task->m;
    const pbw_index *c = m->corner.at[t];
    const unsigned char *mark = m->mark.at;
    pbw_index zone[PBWIM__ZONE], core[10];
    int cores = 4, count, i, k;
    if (task->curve < 0) {
        return 1;
    }
    memcpy(core, c, 4 * sizeof *core);
    for (k = 0; k < 6; k++) {
        pbwim__ring ring;
        ring.a = c[pbwim__edge[k][0]];
        ring.b = c[pbwim__edge[k][1]];
        if (mark[ring.a] != PBW_TETS_FOUND && mark[ring.b] != PBW_TETS_FOUND && pbwim__walk_ring(m, t, &ring)
            && !ring.closed) {
            core[cores++] = ring.corner[0];
            if (!pbwim__has_point(task, ring.corner[0])) {
                return 0;                            /* other threads may change its star */
            }
        }
    }
    count = pbwim__around(m, t, core, cores, zone, PBWIM__ZONE);
    for (i = 0; i < count && pbwim__has_corners(task, zone[i]); i++) {
    }
    return count > 0 && i == count;
}

/* ---- tasks ---- */

/* Returns how many free slots a task begins with: it waits for more where tetrahedra get many. */
static size_t pbwim__task_slots(const pbwim__task *task)
{
    return 2 * PBWIM__SPARE + (task->all ? task->count : task->count / 4);
}

/* Returns how many points a task needs that it does not have. */
static size_t pbwim__task_points(const pbwim__task *task)
{
    const size_t wanted = task->all ? task->count / 2 + 1 : 0;
    return task->point_end - task->m.points < (wanted + 3) / 4 ? wanted : 0;
}

/* Makes a task ready for its tetrahedra: a copy of the mesh, with free points and free slots of its own. */
static void pbwim__begin_task(pbwim__mesh *m, pbwim__task *task)
{
    const pbw_index free = task->m.free;
    const size_t slots = pbwim__task_slots(task), points = pbwim__task_points(task), spare = task->m.spare;
    size_t point = task->m.points, p;
    if (points > 0) {
        point = m->points;
        task->point_end = m->points += points;
        for (p = point; p < task->point_end; p++) {
            memcpy(m->x.at[p], m->x.at[0], sizeof m->x.at[p]);               /* curves may pass before it is used */
            m->star.at[p] = m->original.at[p] = PBW_NONE;
            m->touched.at[p] = m->failed.at[p] = 0;
            m->mark.at[p] = PBW_TETS_FOUND;
        }
    }
    task->m = *m;
    task->m.free = free;
    task->m.spare = spare;
    task->m.points = point;
    task->m.report = &task->report;
    task->changes = task->next = task->waiting = 0;
    memset(&task->report, 0, sizeof task->report);
    while (task->m.spare < slots) {
        pbwim__free_slot(&task->m, pbwim__new_slot(m));
    }
    while (task->m.spare > 2 * slots) {
        pbwim__free_slot(m, pbwim__new_slot(&task->m));
    }
}

/* Merges the changes of a task into the mesh. */
static void pbwim__end_task(pbwim__mesh *m, const pbwim__task *task)
{
    pbw_improve_report *sum = m->report;
    const pbw_improve_report *r = &task->report;
    m->clock = task->m.clock > m->clock ? task->m.clock : m->clock;
    m->visit = task->m.visit > m->visit ? task->m.visit : m->visit;
    sum->removals += r->removals;
    sum->boundary_removals += r->boundary_removals;
    sum->smoothings += r->smoothings;
    sum->slides += r->slides;
    sum->peelings += r->peelings;
    sum->flips += r->flips;
    sum->contractions += r->contractions;
    sum->insertions += r->insertions;
}

/* Improves the tetrahedra of blocks, for one leg; those that must wait come first in the task's list, in order. */
static pbw_status pbwim__improve_blocks(void *arg, size_t from, size_t to)
{
    for (; from < to; from++) {
        pbwim__task *tasks = ((pbwim__mesh *)arg)->tasks.at, *task = tasks + tasks[from].turn;
        pbwim__mesh *m = &task->m;
        if (task->next == 0) {
            qsort(task->item, task->count, sizeof *task->item, pbwim__compare_items);
        }
        for (m->effort = 0; task->next < task->count && m->effort < PBWIM__LEG; task->next++) {
            const pbwim__item item = task->item[task->next];
            const pbw_index t = item.t;
            int has;
            if (!pbwim__is_bad(m, t)) {
                continue;
            }
            m->effort += PBWIM__ITEM_EFFORT;
            has = pbwim__has_corners(task, t);       /* else other threads may touch some of them */
            if (has && !pbwim__is_due(m, t, task->all)) {
                continue;
            }
            if (has && m->spare >= PBWIM__SPARE && !(task->all && m->points == task->point_end) && !pbwim__is_late(m)
                && pbwim__has_zone(task, t)) {
                task->changes += (size_t)pbwim__improve_tet(m, t, task->all);
            } else {
                task->item[task->waiting++] = item;
            }
        }
    }
    return PBW_OK;
}

/* ---- rounds of blocks ---- */

typedef struct pbwim__blocks {             /* along a curve; -1: one block */
    int curve;
    size_t count;
    pbw_index width, shift;                /* block i: places from i width - shift to (i + 1) width - shift */
} pbwim__blocks;

/* Returns the blocks of the pass's round i. */
static pbwim__blocks pbwim__blocks_of(const pbwim__mesh *m, int i)
{
    const size_t points = m->placed > 0 ? m->placed : m->points;
    const size_t by_points = points / PBWIM__BLOCK_POINTS, by_items = m->queue.count / PBWIM__BLOCK_ITEMS;
    const size_t most = (by_points < PBWIM__BLOCKS ? by_points : (size_t)PBWIM__BLOCKS) >> (i / 2 < 9 ? i / 2 : 9);
    pbwim__blocks blocks = { -1, 1, 0, 0 };
    const size_t count = most < by_items ? most : by_items;
    if (count > 1) {
        blocks.curve = i % 2;
        blocks.width = (pbw_index)(points / count + 1);
        blocks.shift = i / 2 % 2 == 1 ? blocks.width / 2 : 0;
        blocks.count = (points - 1 + blocks.shift) / blocks.width + 1;
    }
    return blocks;
}

/* Sorts the queue into the lists of the blocks' tasks.  Returns 0 if there is no memory. */
static int pbwim__deal(pbwim__mesh *m, const pbwim__blocks *blocks, int all)
{
    pbwim__item *item = m->queue.at;
    pbwim__task *task;
    size_t i, left = 0, at = 0;
    if (!PBW_RESERVE(&m->memory, m->sorted, m->queue.count + 1)
        || (m->tasks.count < blocks->count && !PBW_RESERVE(&m->memory, m->tasks, blocks->count - m->tasks.count))) {
        return 0;
    }
    for (; m->tasks.count < blocks->count; m->tasks.count++) {
        memset(m->tasks.at + m->tasks.count, 0, sizeof *m->tasks.at);
        m->tasks.at[m->tasks.count].m.free = PBW_NONE;
    }
    task = m->tasks.at;
    for (i = 0; i < blocks->count; i++) {
        task[i].all = all;
        task[i].count = 0;
        task[i].curve = blocks->curve;
        task[i].first = (pbw_index)i * blocks->width - (i > 0 ? blocks->shift : 0);
        task[i].last = (pbw_index)(i + 1) * blocks->width - blocks->shift;
    }
    for (i = 0; i < m->queue.count; i++) {
        const pbw_index p = *m->corner.at[item[i].t];
        if (p != PBW_NONE) {
            item[left] = item[i];
            item[left].block = blocks->curve < 0
                             ? 0 : (m->place.at[p][blocks->curve] + blocks->shift) / blocks->width;
            task[item[left++].block].count++;
        }
    }
    for (i = 0; i < blocks->count; i++) {
        task[i].item = m->sorted.at + at;
        at += task[i].count;
        task[i].count = 0;
    }
    for (i = 0; i < left; i++) {
        pbwim__task *of = task + item[i].block;
        of->item[of->count++] = item[i];
    }
    return 1;
}

/* One round: all blocks at once.  What must wait is the queue after it. */
static pbw_status pbwim__round(pbwim__mesh *m, const pbwim__blocks *blocks, size_t *changes)
{
    const double end = m->done[1];
    size_t slots = 0, points = 0, left = blocks->count, i, k;
    pbwim__task *task = m->tasks.at;
    pbw_status status = PBW_OK;
    for (i = 0; i < blocks->count; i++) {
        slots += pbwim__task_slots(task + i);
        points += pbwim__task_points(task + i);
    }
    if (!pbwim__reserve(m, slots, points)) {
        return PBW_ERROR_MEMORY;
    }
    if (m->visit > PBW_NONE / 2) {                   /* so that it overflows in no task */
        memset(m->seen.at, 0, m->seen.capacity * sizeof *m->seen.at);
        m->visit = 0;
    }
    for (i = 0; i < blocks->count; i++) {
        pbwim__begin_task(m, task + i);
        for (k = i; k > 0 && task[task[k - 1].turn].count < task[i].count; k--) {
            task[k].turn = task[k - 1].turn;
        }
        task[k].turn = i;
    }
    while (left > 0 && status == PBW_OK) {
        m->done[1] = 0.5 * (m->done[0] + end);
        status = pbwim__for(m, left, 1, pbwim__improve_blocks, m);
        m->done[0] = m->done[1];
        for (i = k = 0; i < left; i++) {
            task[k].turn = task[i].turn;
            k += task[task[i].turn].next < task[task[i].turn].count;
        }
        left = k;
    }
    m->queue.count = 0;
    for (i = 0; i < blocks->count && status == PBW_OK; i++) {
        memcpy(m->queue.at + m->queue.count, task[i].item, task[i].waiting * sizeof *task[i].item);
        m->queue.count += task[i].waiting;
        pbwim__end_task(m, task + i);
        *changes += task[i].changes;
    }
    return status;
}

/* One pass; *changes: how many operations succeeded.  It ends early when the budget is spent. */
static pbw_status pbwim__pass(pbwim__mesh *m, int all, const double done[2], size_t *changes)
{
    pbw_status status;
    int i;
    *changes = 0;
    m->done[0] = m->done[1] = done[0];
    status = pbwim__fill_queue(m, all);
    for (i = 0; status == PBW_OK && m->queue.count > 0 && !pbwim__is_late(m); i++) {
        pbwim__blocks blocks = pbwim__blocks_of(m, i);
        if (blocks.curve >= 0 && m->placed == 0) {
            status = pbwim__place_points(m);
            blocks = pbwim__blocks_of(m, i);
        }
        m->done[1] = blocks.curve < 0 ? done[1] : 0.5 * (m->done[0] + done[1]);
        if (status == PBW_OK) {
            status = pbwim__deal(m, &blocks, all) ? pbwim__round(m, &blocks, changes) : PBW_ERROR_MEMORY;
        }
        m->done[0] = m->done[1];
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>sizes        Edges halved and contracted until they are as long as the sizes at their ends demand.
   Holds: conformity, regions, features; halves of positive tetrahedra are positive, by exact signs.
   ------------------------------------------------------------------------------------------------------ */
#define PBWIM__LONG 1.4
#define PBWIM__SHORT 0.5
#define PBWIM__FLOOR 0.17                  /* the sine of 10 degrees: no contraction makes worse tetrahedra */

/* Returns the length of an edge of t, divided by the length that it should have. */
static double pbwim__ratio(const pbwim__mesh *m, pbw_index t, int e)
{
    const pbw_index a = m->corner.at[t][pbwim__edge[e][0]], b = m->corner.at[t][pbwim__edge[e][1]];
    return 2 * pbwsf__distance(m->x.at[a], m->x.at[b]) / (m->size.at[a] + m->size.at[b]);
}

/* The mark of the middle of the ring's edge. */
static unsigned char pbwim__middle_mark(const pbwim__mesh *m, const pbwim__ring *ring)
{
    double n[2][3];
    int i;
    for (i = 1; i < ring->tets; i++) {
        if (m->region.at[ring->tet[i]] != m->region.at[ring->tet[0]]) {
            return PBW_TETS_FIXED;
        }
    }
    if (pbwim__is_border(m, ring) || pbwim__is_kept(m, ring->a, ring->b)) {
        return PBW_TETS_FIXED;
    }
    if (ring->closed) {
        return PBW_TETS_FOUND;
    }
    pbwsf__normal(m->x.at[ring->a], m->x.at[ring->b], m->x.at[ring->corner[0]], n[0]);
    pbwsf__normal(m->x.at[ring->b], m->x.at[ring->a], m->x.at[ring->corner[ring->corners - 1]], n[1]);
    return pbwim__turned_less(n[0], n[1], m->cosine) ? PBW_TETS_SLIDES : PBW_TETS_FIXED;
}

/* Puts point p at x, and the halves of the ring's tetrahedra into `change`.  Returns whether all are positive. */
static int pbwim__set_halves(pbwim__mesh *m, const pbwim__ring *ring, const double x[3], pbwim__change *change)
{
    const pbw_index p = (pbw_index)m->points;
    int i, k;
    memcpy(m->x.at[p], x, 3 * sizeof *x);
    change->halves = 1;
    change->olds = ring->tets;
    change->news = 2 * ring->tets;
    memcpy(change->old, ring->tet, sizeof ring->tet);
    for (i = 0; i < ring->tets; i++) {
        for (k = 0; k < 4; k++) {
            const pbw_index c = m->corner.at[ring->tet[i]][k];
            change->fresh[2 * i][k] = c == ring->a ? p : c;
            change->fresh[2 * i + 1][k] = c == ring->b ? p : c;
        }
    }
    return pbwim__is_sound(m, change);
}

static int pbwim__halve(pbwim__mesh *m, pbw_index t, int e)
{
    const pbw_index p = (pbw_index)m->points;
    const unsigned char *joint = m->joint.at;
    pbwim__change change;
    pbwim__ring ring;
    double x[3], middle[3];
    unsigned char mark;
    ring.a = m->corner.at[t][pbwim__edge[e][0]];
    ring.b = m->corner.at[t][pbwim__edge[e][1]];
    if (!pbwim__walk_ring(m, t, &ring) || pbwim__is_frozen(m, &ring)
        || (ring.a < m->joint.capacity - 1 && joint[ring.a] && ring.b < m->joint.capacity - 1 && joint[ring.b])) {
        return 0;                                    /* there may be another ring */
    }
    mark = pbwim__middle_mark(m, &ring);
    pbwsf__between(m->x.at[ring.a], m->x.at[ring.b], 0.5, middle);
    memcpy(x, middle, sizeof x);
    if (mark == PBW_TETS_SLIDES) {
        m->project(m->project_user, x);
    }
    if (!pbwim__set_halves(m, &ring, x, &change) && !pbwim__set_halves(m, &ring, middle, &change)) {
        return 0;
    }
    m->points++;
    m->failed.at[p] = 0;
    m->mark.at[p] = mark;
    m->size.at[p] = (m->size.at[ring.a] + m->size.at[ring.b]) / 2;
    m->original.at[p] = PBW_NONE;
    if (m->placed > 0) {
        memcpy(m->place.at[p], m->place.at[ring.a], sizeof m->place.at[p]);
    }
    if (pbwim__is_kept(m, ring.a, ring.b)) {
        pbwim__kept_edge *whole = pbwim__find_edge(m, ring.a, ring.b);
        const pbw_index origin = whole->origin;
        whole->origin = PBW_NONE;
        pbwim__keep_edge(m, ring.a, p, origin);
        pbwim__keep_edge(m, p, ring.b, origin);
    }
    pbwim__apply(m, &change);
    m->report->splits++;
    return 1;
}

/* The longest edge of t, or the shortest. */
static int pbwim__extreme_edge(const pbwim__mesh *m, pbw_index t, int longest, double *ratio)
{
    int e, best = 0;
    *ratio = pbwim__ratio(m, t, 0);
    for (e = 1; e < 6; e++) {
        const double r = pbwim__ratio(m, t, e);
        if (longest ? r > *ratio : r < *ratio) {
            *ratio = r;
            best = e;
        }
    }
    return best;
}

static int pbwim__edges_fit(const pbwim__mesh *m, pbw_index t, int longest, int *e, double *ratio)
{
    if (*m->corner.at[t] == PBW_NONE) {
        return 1;
    }
    *e = pbwim__extreme_edge(m, t, longest, ratio);
    return longest ? *ratio <= PBWIM__LONG : *ratio >= PBWIM__SHORT;
}

/* One round over the tetrahedra with edges that are too long, or too short, worst first. */
static pbw_status pbwim__resize_edges(pbwim__mesh *m, int longest, size_t *changes)
{
    pbwim__item *item;
    double ratio;
    size_t t, i, count = 0;
    int e;
    for (t = 0; t < m->tets; t++) {
        count += !pbwim__edges_fit(m, (pbw_index)t, longest, &e, &ratio);
    }
    m->queue.count = 0;
    if (!PBW_RESERVE(&m->memory, m->queue, count + 1)) {
        return PBW_ERROR_MEMORY;
    }
    item = m->queue.at;
    for (t = 0; t < m->tets; t++) {
        if (!pbwim__edges_fit(m, (pbw_index)t, longest, &e, &ratio)) {
            item[m->queue.count].quality = longest ? -ratio : ratio;
            item[m->queue.count++].t = (pbw_index)t;
        }
    }
    qsort(item, m->queue.count, sizeof *item, pbwim__compare_items);
    for (i = 0; i < m->queue.count; i++) {
        const pbw_index at = item[i].t;
        if (i % 64 == 0 && pbwim__progress(m, 0)) {
            return PBW_CANCELLED;
        }
        if (!pbwim__reserve(m, 0, 0)) {
            return PBW_ERROR_MEMORY;
        }
        if (!pbwim__edges_fit(m, at, longest, &e, &ratio)) {
            const pbw_index a = m->corner.at[at][pbwim__edge[e][0]];
            const pbw_index b = m->corner.at[at][pbwim__edge[e][1]];
            *changes += (size_t)(longest ? pbwim__halve(m, at, e) : pbwim__contract_to(m, at, a, b, PBWIM__FLOOR)
                                 || pbwim__contract_to(m, at, b, a, PBWIM__FLOOR));
        }
    }
    return PBW_OK;
}

static pbw_status pbwim__set_sizes(pbwim__mesh *m)
{
    pbw_status status = PBW_OK;
    size_t changes = 1, ignored;
    const double done[2] = { 0, 0 };
    int round;
    for (round = 0; round < 32 && changes > 0 && status == PBW_OK; round++) {
        changes = 0;
        status = pbwim__resize_edges(m, 0, &changes);
        status = status != PBW_OK ? status : pbwim__resize_edges(m, 1, &changes);
        status = status != PBW_OK ? status : pbwim__pass(m, 0, done, &ignored);
        if (pbwim__is_late(m)) {
            break;
        }
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>result       The mesh written to the caller's arrays.
   In: the mesh.  Out: its slots in use, and its points of tetrahedra, numbered in their order.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwim__result {
    pbw_memory memory;
    size_t bytes;                          /* of all of it */
    pbwsf__vectors points;
    pbwsf__quadruples corners, neighbors, patches;
    pbwsf__indices regions, original, origins;
    pbwsf__flags marks;
    pbwsf__pairs edges;
} pbwim__result;

static int pbwim__allocate(pbwim__result *r, size_t points, size_t tets, int patched, size_t edges)
{
    pbw_memory *y = &r->memory;
    return (!patched || PBW_FIT(y, r->patches, tets + 1))
        && (edges == 0 || (PBW_FIT(y, r->edges, edges)
                           && PBW_FIT(y, r->origins, edges)))
        && PBW_FIT(y, r->points, points + 1)
        && PBW_FIT(y, r->corners, tets + 1)
        && PBW_FIT(y, r->neighbors, tets + 1)
        && PBW_FIT(y, r->regions, tets + 1)
        && PBW_FIT(y, r->original, points + 1)
        && PBW_FIT(y, r->marks, points + 1);
}

static int pbwim__compare_edges(const void *a, const void *b)
{
    const pbwim__kept_edge *x = (const pbwim__kept_edge *)a, *y = (const pbwim__kept_edge *)b;
    return x->origin != y->origin ? (x->origin > y->origin) - (x->origin < y->origin)
         : x->a != y->a ? (x->a > y->a) - (x->a < y->a) : (x->b > y->b) - (x->b < y->b);
}

/* Puts edges first in their table.  Returns how many there are. */
static size_t pbwim__sort_edges(pbwim__mesh *m)
{
    pbwim__kept_edge *e = m->edge.at;
    size_t i, count = 0;
    for (i = 0; i < m->edge.capacity; i++) {
        if (e[i].origin != PBW_NONE) {
            e[count++] = e[i];
        }
    }
    if (count > 0) {
        qsort(e, count, sizeof *e, pbwim__compare_edges);
    }
    return count;
}

static pbw_status pbwim__count_tets(void *arg, size_t from, size_t to)
{
    const pbwim__mesh *m = (const pbwim__mesh *)arg;
    size_t t, count = 0;
    for (t = from; t < to; t++) {
        count += *m->corner.at[t] != PBW_NONE;
    }
    m->tally.at[from / PBWIM__SLICE] = count;
    return PBW_OK;
}

/* Numbers tetrahedra in `tried`, which is no longer needed. */
static pbw_status pbwim__number_tets(void *arg, size_t from, size_t to)
{
    const pbwim__mesh *m = (const pbwim__mesh *)arg;
    size_t t, count = m->tally.at[from / PBWIM__SLICE];
    for (t = from; t < to; t++) {
        if (*m->corner.at[t] != PBW_NONE) {
            m->tried.at[t][0] = (pbw_index)count++;
        }
    }
    return PBW_OK;
}

static pbw_status pbwim__count_points(void *arg, size_t from, size_t to)
{
    const pbwim__mesh *m = (const pbwim__mesh *)arg;
    size_t p, count = 0;
    for (p = from; p < to; p++) {
        count += m->star.at[p] != PBW_NONE;
    }
    m->tally.at[from / PBWIM__SLICE] = count;
    return PBW_OK;
}

/* Numbers points in `star`. */
static pbw_status pbwim__number_points(void *arg, size_t from, size_t to)
{
    const pbwim__mesh *m = (const pbwim__mesh *)arg;
    size_t p, count = m->tally.at[from / PBWIM__SLICE];
    for (p = from; p < to; p++) {
        if (m->star.at[p] != PBW_NONE) {
            m->star.at[p] = (pbw_index)count++;
        }
    }
    return PBW_OK;
}

/* Numbers tetrahedra, or points.  *count: how many are in use. */
static pbw_status pbwim__number(pbwim__mesh *m, int tets, size_t *count)
{
    const size_t slots = tets ? m->tets : m->points;
    pbw_status status = pbwim__for(m, slots, PBWIM__SLICE, tets ? pbwim__count_tets : pbwim__count_points, m);
    if (status == PBW_OK) {
        *count = pbwim__sum_up(m->tally.at, pbwim__slices(slots));
        status = pbwim__for(m, slots, PBWIM__SLICE, tets ? pbwim__number_tets : pbwim__number_points, m);
    }
    return status;
}

typedef struct pbwim__copying {
    const pbwim__mesh *m;
    const pbwim__result *r;
} pbwim__copying;

static pbw_status pbwim__copy_points(void *arg, size_t from, size_t to)
{
    const pbwim__mesh *m = ((const pbwim__copying *)arg)->m;
    const pbwim__result *r = ((const pbwim__copying *)arg)->r;
    size_t p;
    for (p = from; p < to; p++) {
        const pbw_index n = m->star.at[p];
        if (n != PBW_NONE) {
            memcpy(r->points.at[n], m->x.at[p], sizeof *r->points.at);
            r->marks.at[n] = m->mark.at[p];
            r->original.at[n] = m->original.at[p];
        }
    }
    return PBW_OK;
}

static pbw_status pbwim__copy_tets(void *arg, size_t from, size_t to)
{
    const pbwim__mesh *m = ((const pbwim__copying *)arg)->m;
    const pbwim__result *r = ((const pbwim__copying *)arg)->r;
    size_t t, k;
    for (t = from; t < to; t++) {
        const size_t n = m->tried.at[t][0];
        for (k = 0; k < 4 && *m->corner.at[t] != PBW_NONE; k++) {
            const pbw_index next = m->next.at[t][k];
            r->corners.at[n][k] = m->star.at[m->corner.at[t][k]];
            r->neighbors.at[n][k] = next != PBW_NONE ? m->tried.at[next][0] : PBW_NONE;
            r->regions.at[n] = m->region.at[t];
            if (m->patched) {
                r->patches.at[n][k] = m->patch.at[t][k];
            }
        }
    }
    return PBW_OK;
}

PBWDEF void pbw_tets_free(pbw_tets *mesh)
{
    if (mesh != NULL && mesh->memory != NULL) {
        pbwim__result *r = (pbwim__result *)mesh->memory;
        pbw_memory memory = r->memory;
        PBW_RELEASE(&memory, r->points);
        PBW_RELEASE(&memory, r->corners);
        PBW_RELEASE(&memory, r->neighbors);
        PBW_RELEASE(&memory, r->regions);
        PBW_RELEASE(&memory, r->original);
        PBW_RELEASE(&memory, r->marks);
        PBW_RELEASE(&memory, r->patches);
        PBW_RELEASE(&memory, r->edges);
        PBW_RELEASE(&memory, r->origins);
        (void)pbw_memory_resize(&memory, r, 1, 0, sizeof *r);
    }
    if (mesh != NULL) {
        memset(mesh, 0, sizeof *mesh);
    }
}

/* Returns how many bytes a result holds. */
PBWSF__SHARED static size_t pbwim__result_bytes(const pbw_tets *tets)
{
    const pbwim__result *r = (const pbwim__result *)tets->memory;
    return r == NULL ? 0 : r->bytes;
}

static pbw_status pbwim__output(pbwim__mesh *m, pbw_tets *out)
{
    const pbwim__kept_edge *e = m->edge.at;
    const int fits = PBW_FIT(&m->memory, m->tally, pbwim__slices(m->points > m->tets ? m->points : m->tets) + 1);
    const size_t used = m->memory.used;
    pbw_status status = fits ? pbwim__number(m, 1, &out->tet_count) : PBW_ERROR_MEMORY;
    pbwim__copying copying;
    pbwim__result *r;
    size_t i;
    status = status != PBW_OK ? status : pbwim__number(m, 0, &out->point_count);
    r = status == PBW_OK ? (pbwim__result *)pbw_memory_resize(&m->memory, NULL, 0, 1, sizeof *r) : NULL;
    if (r == NULL) {
        out->tet_count = out->point_count = 0;
        return status != PBW_OK ? status : PBW_ERROR_MEMORY;
    }
    out->edge_count = pbwim__sort_edges(m);
    memset(r, 0, sizeof *r);
    r->memory = m->memory;
    out->memory = r;
    if (!pbwim__allocate(r, out->point_count, out->tet_count, m->patched, out->edge_count)) {
        pbw_tets_free(out);
        return PBW_ERROR_MEMORY;
    }
    copying.m = m;
    copying.r = r;
    r->bytes = r->memory.used - used;
    m->memory.used = r->memory.used;
    for (i = 0; i < out->edge_count; i++) {
        r->edges.at[i][0] = m->star.at[e[i].a];
        r->edges.at[i][1] = m->star.at[e[i].b];
        r->origins.at[i] = e[i].origin;
    }
    status = pbwim__for(m, m->points, PBWIM__SLICE, pbwim__copy_points, &copying);
    status = status != PBW_OK ? status : pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__copy_tets, &copying);
    if (status != PBW_OK) {
        pbw_tets_free(out);
        return status;
    }
    out->points = (const double *)r->points.at;
    out->corners = (const pbw_index *)r->corners.at;
    out->neighbors = (const pbw_index *)r->neighbors.at;
    out->regions = r->regions.at;
    out->original = r->original.at;
    out->marks = r->marks.at;
    out->patches = (const pbw_index *)r->patches.at;
    out->edges = (const pbw_index *)r->edges.at;
    out->edge_origins = r->origins.at;
    return PBW_OK;
}

/* Links tetrahedra at boundary facets that have the same corners: where the boundary touches itself, an operation may
   close the space between two sheets of it. */
static pbw_status pbwim__close_gaps(pbwim__mesh *m)
{
    pbwim__sorting sorting;
    pbwim__bounding b = { m, NULL, NULL, NULL };
    pbw_status status = pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__count_boundary, m);
    size_t count, i;
    if (status != PBW_OK) {
        return status;
    }
    memset(&sorting, 0, sizeof sorting);
    count = pbwim__sum_up(m->tally.at, pbwim__slices(m->tets));
    status = pbwim__begin_sorting(&m->memory, &sorting, count, m->points) ? PBW_OK : PBW_ERROR_MEMORY;
    b.facets = sorting.items.at;
    status = status != PBW_OK ? status : pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__list_boundary, &b);
    if (status == PBW_OK) {
        const pbw_options inner = pbwim__inner_options(m->options, &m->memory);
        const pbwim__facet *f = pbwim__sort(&inner, &sorting, count, 3);
        status = f != NULL ? PBW_OK : PBW_ERROR_MEMORY;
        for (i = 0; f != NULL && i + 1 < count; i++, f++) {
            if (memcmp(f->v, f[1].v, sizeof f->v) == 0
                && pbwim__facet_parity(m, f->t, f->i) != pbwim__facet_parity(m, f[1].t, f[1].i)) {
                m->next.at[f->t][f->i] = f[1].t;
                m->next.at[f[1].t][f[1].i] = f->t;
            }
        }
    }
    pbwim__end_sorting(&m->memory, &sorting);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>stages       All of it in order.
   In: what the caller gives.  Out: the improved mesh, and the report.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwim__bad { size_t count; double least; } pbwim__bad;

typedef struct pbwim__counting { const pbwim__mesh *m; pbwim__bad *slice; } pbwim__counting;

static pbw_status pbwim__count_bad_slice(void *arg, size_t from, size_t to)
{
    const pbwim__counting *work = (const pbwim__counting *)arg;
    pbwim__bad *bad = work->slice + from / PBWIM__SLICE;
    bad->count = 0;
    bad->least = 1;
    for (; from < to; from++) {
        if (pbwim__is_bad(work->m, (pbw_index)from)) {
            bad->count++;
            bad->least = fmin(bad->least, work->m->quality.at[from]);
        }
    }
    return PBW_OK;
}

/* Counts the tetrahedra below the target. */
static pbw_status pbwim__count_bad(pbwim__mesh *m, pbwim__bad *bad)
{
    const size_t slices = pbwim__slices(m->tets);
    PBW_ARRAY(pbwim__bad) parts = { NULL, 0, 0 };
    pbwim__counting work = { m, NULL };
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i;
    bad->count = 0;
    bad->least = 1;
    if (PBW_FIT(&m->memory, parts, slices + 1)) {
        work.slice = parts.at;
        status = pbwim__for(m, m->tets, PBWIM__SLICE, pbwim__count_bad_slice, &work);
    }
    for (i = 0; i < slices && status == PBW_OK; i++) {
        bad->count += parts.at[i].count;
        bad->least = fmin(bad->least, parts.at[i].least);
    }
    PBW_RELEASE(&m->memory, parts);
    return status;
}

/* *badness: the number of tetrahedra below the target, times 1 minus the worst quality. */
static pbw_status pbwim__measure_badness(pbwim__mesh *m, double *badness)
{
    pbwim__bad bad;
    const pbw_status status = pbwim__count_bad(m, &bad);
    *badness = (double)bad.count * (1 - bad.least);
    return status;
}

/* Forgets at which points smoothing failed: the target or the distance allowed is another. */
static void pbwim__forget_failures(pbwim__mesh *m)
{
    memset(m->failed.at, 0, m->points * sizeof *m->failed.at);
}

/* When passes gain no more: allows the boundary its full distance from the surface.  Returns 0 if it has that. */
static int pbwim__relax_distance(pbwim__mesh *m, const pbw_improve_options *how)
{
    const int relaxed = how != NULL && m->distance < how->distance;
    if (relaxed) {
        pbwim__forget_failures(m);
    }
    m->distance = relaxed ? how->distance : m->distance;
    return relaxed;
}

/* Eight final passes around the bad tetrahedra: four with a higher target, which changes their neighbours, then four
   with the old one.  While it is higher, the boundary moves no farther from the surface.  In all eight, smoothing
   climbs in random directions, smaller gains do, and boundary facets may turn by more. */
static pbw_status pbwim__final_passes(pbwim__mesh *m, double raise, double done[2])
{
    const double target = m->target, distance = m->distance;
    pbw_status status = PBW_OK;
    size_t changes;
    int i;
    m->turn = PBWIM__FINAL_COSINE;
    m->smooth_gain = PBWIM__FINAL_GAIN;
    m->turned = 1;
    status = pbwim__flag_active(m);
    memset(m->tried.at, 0, m->tets * sizeof *m->tried.at);
    for (i = 0; i < 8 && status == PBW_OK && !pbwim__is_late(m); i++) {
        if (i % 4 == 0) {
            pbwim__forget_failures(m);
        }
        m->target = i < 4 ? sin(fmin(asin(target) + raise, 1.2)) : target;
        m->distance = i < 4 && distance > 0 ? 1e-300 : distance;
        done[1] = done[0] + (1 - done[0]) / 8;
        status = pbwim__pass(m, 1, done, &changes);
        done[0] = done[1];
        m->report->passes++;
    }
    pbwim__forget_failures(m);
    m->target = target;
    m->distance = distance;
    m->active.count = 0;
    return status;
}

/* Passes end, too, when eight of them changed the badness by less than 3 %. */
static pbw_status pbwim__passes(pbwim__mesh *m, const pbw_improve_options *how)
{
    const int most = how == NULL || how->passes == 0 ? PBWIM__PASSES : how->passes;
    pbw_status status = PBW_OK;
    double done[2] = { 0, 0 }, bad = HUGE_VAL;
    size_t changes = 1;
    int all = 0, i;
    if (m->sized) {
        status = pbwim__set_sizes(m);
    }
    if (how != NULL && how->rounds > 0 && status == PBW_OK) {
        status = pbwim__smooth_all(m, how);
        done[0] = 0.5;
    }
    while (status == PBW_OK && m->report->passes < most && !pbwim__is_late(m)
           && (changes > 0 || !all || pbwim__relax_distance(m, how))) {
        all = m->report->passes % 4 == 3 || changes * 5 < m->queue.count || changes == 0;
        done[1] = done[0] + (1 - done[0]) / 8;
        status = pbwim__pass(m, all, done, &changes);
        done[0] = done[1];
        m->report->passes++;
        if (m->report->passes % 8 == 0) {
            double now = 0;
            status = status != PBW_OK ? status : pbwim__measure_badness(m, &now);
            if (now > 0.97 * bad && !pbwim__relax_distance(m, how)) {
                break;
            }
            bad = now;
        }
    }
    for (i = 1; i <= 2 && status == PBW_OK && !pbwim__is_late(m)
         && (most == PBWIM__PASSES || m->report->passes + 8 <= most); i++) {
        double now;
        status = pbwim__measure_badness(m, &now);
        if (status != PBW_OK || !(now > 0) || (i > 1 && now >= 0.97 * bad)) {
            break;
        }
        bad = now;
        status = pbwim__final_passes(m, i * PBWIM__FINAL_RAISE, done);
    }
    return status;
}

static void pbwim__free(pbwim__mesh *m)
{
    m->memory.used -= pbwsf__bytes(&m->surface);
    pbw_surface_free(&m->surface);
    PBW_RELEASE(&m->memory, m->x);
    PBW_RELEASE(&m->memory, m->star);
    PBW_RELEASE(&m->memory, m->mark);
    PBW_RELEASE(&m->memory, m->touched);
    PBW_RELEASE(&m->memory, m->failed);
    PBW_RELEASE(&m->memory, m->original);
    PBW_RELEASE(&m->memory, m->corner);
    PBW_RELEASE(&m->memory, m->next);
    PBW_RELEASE(&m->memory, m->quality);
    PBW_RELEASE(&m->memory, m->region);
    PBW_RELEASE(&m->memory, m->tried);
    PBW_RELEASE(&m->memory, m->seen);
    PBW_RELEASE(&m->memory, m->queue);
    PBW_RELEASE(&m->memory, m->sorted);
    PBW_RELEASE(&m->memory, m->tasks);
    PBW_RELEASE(&m->memory, m->place);
    PBW_RELEASE(&m->memory, m->tally);
    PBW_RELEASE(&m->memory, m->facets);
    PBW_RELEASE(&m->memory, m->size);
    PBW_RELEASE(&m->memory, m->joint);
    PBW_RELEASE(&m->memory, m->active);
    PBW_RELEASE(&m->memory, m->patch);
    PBW_RELEASE(&m->memory, m->edge);
}

/* Loads, works, and writes the result. */
static pbw_status pbwim__run(pbwim__mesh *m, const pbw_tets *in, const pbw_improve_options *how, pbw_tets *better)
{
    const double angle = how != NULL && how->feature_angle > 0 ? how->feature_angle : 40;
    pbw_status status = pbwim__load(m, in);
    pbwim__bad bad = { 0, 1 };
    pbw_options inner;
    pbw_tets view;
    size_t t;
    if (status != PBW_OK) {
        return status;
    }
    m->cosine = cos(angle / 57.295779513082321);
    m->turn = PBWIM__SMOOTH_COSINE;
    m->smooth_gain = PBWIM__SMOOTH_GAIN;
    for (t = 0; t < m->points && m->sized; t++) {
        if (!(how->sizes[t] > 0 && how->sizes[t] <= 1e300)) {
            pbwim__set_message(m, "size %zu is not above 0", t, 0);
            return PBW_ERROR_ARGUMENT;
        }
        m->size.at[t] = how->sizes[t];
    }
    status = pbwim__progress(m, 0) ? PBW_CANCELLED : pbwim__connect(m, in, m->cosine);
    memset(&view, 0, sizeof view);
    view.points = in->points;
    view.corners = (const pbw_index *)m->corner.at;
    view.tet_count = m->tets;
    inner = pbwim__loop_options(m);
    if (status == PBW_OK && pbwim__progress(m, 0)) {
        return PBW_CANCELLED;
    }
    (void)pbwim__measure(&view, &inner, &m->report->before);
    status = status != PBW_OK ? status : m->cancelled || pbwim__progress(m, 0) ? PBW_CANCELLED
           : pbwim__passes(m, how);
    status = status != PBW_OK ? status : pbwim__progress(m, m->done[0]) ? PBW_CANCELLED : pbwim__close_gaps(m);
    status = status != PBW_OK ? status : pbwim__progress(m, 1) ? PBW_CANCELLED : pbwim__count_bad(m, &bad);
    m->report->left = bad.count;
    return status != PBW_OK ? status : pbwim__output(m, better);
}

PBWDEF pbw_status pbw_improve(const pbw_tets *mesh, const pbw_improve_options *how,
                              const pbw_options *options, pbw_tets *better, pbw_improve_report *report)
{
    pbwim__mesh m;
    pbw_improve_report own;
    pbw_options shared;
    pbw_threads *threads;
    pbw_status status;
    const double target = how != NULL && how->target > 0 ? how->target : 30;
    memset(&m, 0, sizeof m);
    report = report != NULL ? report : &own;
    memset(report, 0, sizeof *report);
    if (better != NULL) {
        memset(better, 0, sizeof *better);
    }
    if (better == NULL || mesh == NULL || !(target >= 1 && target <= 60)
        || (how != NULL && (unsigned)how->smoother > PBW_SMOOTHER_LAPLACIAN)
        || (mesh->tet_count > 0 && (mesh->points == NULL || mesh->corners == NULL))
        || (mesh->edge_count > 0 && mesh->edges == NULL)) {
        return PBW_ERROR_ARGUMENT;
    }
    threads = pbw_threads_start(options, 16 * mesh->tet_count, &shared);
    pbw_memory_start(&m.memory, &shared);
    m.options = &shared;
    m.project = how != NULL ? how->project : NULL;
    m.project_user = how != NULL ? how->project_user : NULL;
    m.distance = how != NULL ? PBWIM__DISTANCE_SHARE * how->distance : 0;
    m.sized = how != NULL && how->sizes != NULL;
    m.patched = mesh->patches != NULL;
    m.target = sin(target / 57.295779513082321);
    m.report = report;
    m.deadline = how != NULL && how->seconds > 0 ? (double)clock() / CLOCKS_PER_SEC + how->seconds : 0;
    status = pbwim__run(&m, mesh, how, better);
    pbwim__free(&m);
    if (status == PBW_OK && report->removals + report->boundary_removals + report->smoothings + report->slides
                            + report->peelings + report->flips + report->contractions + report->insertions
                            + report->splits + report->moves == 0) {
        report->after = report->before;
    } else if (status == PBW_OK) {
        const pbw_options inner = pbwim__loop_options(&m);
        (void)pbwim__measure(better, &inner, &report->after);
        if (m.cancelled) {
            pbw_tets_free(better);
            status = PBW_CANCELLED;
        }
    }
    pbw_threads_stop(threads);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>seam         What pbw_mesh3.h, pbw_adapt3.h and pbw_wrap.h use of the rooms above.
   Holds: the list is what they use, tests/seam.sh compares; whoever changes what a name in it means, raises it.

   They are compiled behind this header, in one source file, and refuse another number.

     pbwim__edge           adapt3 mesh3  measures
     pbwim__opposite       adapt3 mesh3  measures
     pbwim__shape          mesh3         measures
     pbwim__shape_of       mesh3         measures
     pbwim__sine           mesh3         measures
     pbwim__turned_less    mesh3         mesh
     pbwim__facet          mesh3         change
     pbwim__sort3          mesh3         change
     pbwim__begin_sorting  mesh3         load
     pbwim__end_sorting    mesh3         load
     pbwim__sort           mesh3         load
     pbwim__sorting        mesh3         load
     pbwim__result_bytes   mesh3 wrap    result
   ------------------------------------------------------------------------------------------------------ */
#define PBWIM__SEAM 1

PBW_CONTRACTION_ON
#endif /* PBWSF__SEAM */
#endif /* PBW_IMPROVE_IMPLEMENTATION */
