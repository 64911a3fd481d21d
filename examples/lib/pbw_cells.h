/* pbw_cells.h - v0.2.0 - cells of the Voronoi and of the power diagram - MIT-0

   QUICK START
   In one source file, define PBW_CELLS_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file.

       const double box[6] = { 0,0,0, 1,1,1 };                       // low corner, high corner
       pbw_domain domain = {0};
       pbw_cells cells = {0};
       pbw_mesh mesh = {0};
       domain.box = box;
       pbw_triangulate(3, points, NULL, count, NULL, &mesh);
       pbw_cells_of(&mesh, &domain, 0, NULL, &cells);                // of weighted points: power cells
       printf("%g\n", cells.volumes[7]);
       pbw_cells_free(&cells);
       pbw_free(&mesh);

   FUNCTIONS
     pbw_cells_of        the cells of a mesh's vertices in a domain
     pbw_cells_periodic  the cells of points in a periodic box
     pbw_cells_rings     the cells of a mesh's vertices in a polygon with holes
     pbw_cells_free      frees cells

   HOW
   The cell of a vertex is the dual of its star: its corners are the centres of the star's simplices, its facets
   belong to the edges at the vertex.  Facets, and with them volumes and centroids, are computed from the rings of
   simplices around these edges.  For volumes and centroids alone, in space, each simplex contributes to the cells of
   its corners, and no star is walked.  Cells with a corner outside the domain are cut: their polytope by the walls,
   or, at the hull, the domain by one half-space for each neighbour; only neighbours in the triangulation matter, as
   the cell is the intersection of their half-spaces.  All ways sum signed volumes relative to the site, so obtuse
   simplices and centres outside of their simplex are no special cases. The edges of a polygon are followed from cell
   to cell; exact signs decide where they cross and what they enclose. Cutting classifies each corner once, as inside
   or outside, and both facets at a new corner use the same corner: however the signs are rounded, the surface stays
   closed.

   PROMISES  (tests/test_cells.c guards them)
     same        the same bytes for any number of threads; volumes and centroids with facets and alone to 1e-12 of all
     whole       volumes in a domain add up to it, to 1e-12            (polygons: tests/test_clip.c)
     closed      areas times normals of a bounded cell add up to zero
     exact       with PBW_CELLS_MERGE, combinatorics are those of the true diagram, degenerate corners and all, of
                 cells that are cut, too
     bounded     a call holds at most options.memory_limit, the mesh that it makes included

   CONTENTS
     >>interface    types and functions
     >>memory       growing arrays
     >>centres      the centre of a simplex
     >>exact        exact numbers
     >>polytopes    polytopes, and cuts by planes
     >>stars        the simplices at a vertex
     >>volumes      volumes from stars
     >>totals       volumes from simplices
     >>facets       facets of cells that are not cut
     >>cuts         cells cut from the domain
     >>true         cut cells of the true diagram
     >>signs        exact signs for polygons
     >>rings        the boundary of what rings enclose
     >>polygons     polygons as domains
     >>chains       one cell of a polygon
     >>periodic     which copies of points are needed
     >>ranges       ranges of points, and their parts in one
     >>merging      centres that coincide
     >>domain       the domain as a polytope
     >>flat         points on a line or in a plane
     >>calls        the calls without periods
     >>units        units of periodic boxes
     >>rounds       copies and rounds

   CONFIGURATION MACROS
     PBW_CELLS_IMPLEMENTATION    in one source file: compile the implementation there
*/
#ifndef PBW_CELLS_H
#define PBW_CELLS_H
#ifndef PBW_H
#include "pbw.h"
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */

#ifdef __cplusplus
extern "C" {
#endif

/* The domain that bounds the cells.  All zero: the whole space, and cells at the hull are unbounded. */
typedef struct pbw_domain {
    const double *box;                     /* low corner, high corner: 2*dim numbers; NULL = none */
    const double *planes;                  /* half-spaces n.x <= c: dim numbers n, then c, each; NULL = none */
    size_t plane_count;
    unsigned periodic;                     /* pbw_cells_periodic: bit k = the box repeats along axis k */
    const double *lattice;                 /* pbw_cells_periodic, instead of box and periodic: dim vectors of dim
                                              numbers each, by which all repeats; any angles; NULL = none */
    const double *rings;                   /* in the plane, instead of box and planes: a polygon, which may have holes
                                              and several parts.  Two numbers a corner; NULL = none */
    const size_t *ring_first;              /* ring_count + 1: ring i is corners ring_first[i] .. ring_first[i+1]-1,
                                              the last joined to the first.  Either way round: what is inside an
                                              odd number of rings is inside, and so are edges that rings share */
    size_t ring_count;
} pbw_domain;

#define PBW_CELLS_FACETS 1u                /* fill first, neighbors, areas */
#define PBW_CELLS_SHAPES 2u                /* and vertices, loop_first, loops, rays */
#define PBW_CELLS_MERGE  4u                /* the true diagram: centres that coincide are one vertex, facets without
                                              area are left out.  Slower: an exact sign for each pair of simplices */

typedef struct pbw_cells {                 /* start from {0}; read, do not write; pbw_cells_free when done */
    int dim;
    size_t cell_count;                     /* the mesh's points; hidden points and duplicates have empty cells */
    size_t facet_count, vertex_count, ray_count;
    const double *volumes;                 /* per cell: volume, in the plane area; HUGE_VAL if unbounded */
    const double *centroids;               /* dim per cell; of empty and unbounded cells the point itself */
    const size_t *first;                   /* cell_count + 1: the facets of cell i are first[i] .. first[i+1]-1; in
                                              space those of a cell that the domain does not cut are in the order of
                                              the first simplices that its neighbours share with it */
    const pbw_index *neighbors;            /* per facet: the point beyond; PBW_NONE - 1 - k: wall k of the domain,
                                              where 2*axis and 2*axis+1 are the box, low and high, and planes
                                              follow; of a polygon the edge from corner k of rings to the next */
    const signed char *shifts;             /* pbw_cells_periodic: dim per facet: the neighbour is the point +
                                              shift * box size, of a lattice + the sum of shift[k] * vector k, from
                                              where it was moved to; else NULL */
    const double *sites;                   /* pbw_cells_periodic: dim per cell: where its point was moved to; else
                                              NULL */
    const double *areas;                   /* per facet: area, in the plane length; HUGE_VAL if unbounded.  In space
                                              two cells that the domain does not cut have the same of each other */
    const double *vertices;                /* dim each; the first ones are the centres of the mesh's simplices (it
                                              has none: of those of a mesh around the points) */
    const size_t *loop_first;              /* facet_count + 1 */
    const pbw_index *loops;                /* corners of facet j: loop_first[j] .. loop_first[j+1]-1,
                                              counter-clockwise from outside the cell; in the plane two, and a
                                              cell's facets are in order.  In a polygon a cell may have several
                                              parts, and holes, which turn clockwise: one ends where it is back at
                                              its first corner.  PBW_NONE - 1 - k: at infinity, in direction k of
                                              rays */
    const double *rays;                    /* dim each: directions of length 1 */
    void *memory;                          /* private */
} pbw_cells;

/* Computes the cells of a mesh's points: Voronoi cells, with weights power cells; what: PBW_CELLS_* or'ed.
   domain: NULL = the whole space; else convex and bounded: a box, planes, or both; or a polygon.  Edges of its rings
   must not cross except in corners.  They may touch and lie on each other: neighbours that share edges, or parts of
   edges, become one, and what has no area (spikes, flat rings) is left out.  pbw_cells_rings says where rings cross.
   Coordinates of corners and of points must be 0 or 1e-57 to 1e60 in size, weights 0 or within the squares of those.
   Cells that it only touches are
   empty.  Needs mesh->neighbors.
   Volumes are right if the box of the points and the domain are 1e-57 to 1e60 in size: beyond, products of
   coordinates over- or underflow, and cells lose volume without an error.  Points of a mesh without simplices, one or
   all on a line or in a plane, have cells in a domain; without a domain they give PBW_DEGENERATE and empty cells, and
   so do no points.  Fails as pbw_triangulate does; also with PBW_ERROR_ARGUMENT for a domain that is
   unbounded, empty or periodic, and for rings that cross.  Leaves cells empty then. */
PBWDEF pbw_status pbw_cells_of(const pbw_mesh *mesh, const pbw_domain *domain, unsigned what,
                               const pbw_options *options, pbw_cells *cells);
/* Computes the cells of points in a box that repeats along the axes of domain->periodic and is a wall along the
   others. First moves the points into the box, and along periodic axes rounds coordinates and the box size to
   multiples of about 2^-48 of it (coarser in very long boxes), so that copies are exact translates.
   Of a lattice, the shortest vectors that make the same one are found, and rounded to multiples of a power of two,
   some 2^-45 of the longest of them; points are moved by sums of them into the parallelepiped that they span at the
   origin, and rounded, too.  So cells are exactly those of rounded points in a rounded lattice, and those of yours if
   its coordinates are such multiples.
   Returns PBW_OK for one point or more; PBW_ERROR_ARGUMENT without a box or a lattice, with both, with planes, if
   weights differ so much that copies are not exact, if vectors are flat to 6 digits, and if they are so skew that a
   shift is beyond 127.  A point may be its own neighbour, or twice that of another one, with different shifts. */
PBWDEF pbw_status pbw_cells_periodic(int dim, const double *points, const double *weights, size_t count,
                                     const pbw_domain *domain, unsigned what, const pbw_options *options,
                                     pbw_cells *cells);
/* What the rings of a domain enclose. */
typedef struct pbw_rings {
    double area;
    size_t edges[2];                       /* of rings that cross: two edges, by the corners that they start from, the
                                              lower one first; else both 0 */
    double place[2];                       /* where these cross, rounded */
} pbw_rings;
/* Returns PBW_OK and the area if pbw_cells_of takes the rings of a domain.  PBW_ERROR_ARGUMENT: edges that cross; or
   rings that enclose nothing; or coordinates out of range.  n corners take time n log n. */
PBWDEF pbw_status pbw_cells_rings(const pbw_domain *domain, const pbw_options *options, pbw_rings *found);
PBWDEF void pbw_cells_free(pbw_cells *cells);           /* fine on {0}, fine twice */

#ifdef __cplusplus
}
#endif
#endif /* PBW_CELLS_H */

#if defined(PBW_CELLS_IMPLEMENTATION) && !defined(PBWCELLS__IMPLEMENTED)
#define PBWCELLS__IMPLEMENTED

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* No contraction: fused operations would give other coordinates. */
PBW_CONTRACTION_OFF

/* ------------------------------------------------------------------------------------------------------
   >>memory       Memory: growing arrays through options.resize.
   Holds: used = the sum of all live arrays; over the limit nothing grows.
   ------------------------------------------------------------------------------------------------------ */
typedef PBW_ARRAY(double) pbwc__doubles;
typedef PBW_ARRAY(pbw_index) pbwc__indices;
typedef PBW_ARRAY(size_t) pbwc__sizes;
typedef PBW_ARRAY(unsigned char) pbwc__bytes;
typedef double pbwc__vector[3];

/* ------------------------------------------------------------------------------------------------------
   >>centres      Where the bisectors (with weights: radical planes) of a simplex meet.
   In: the corners of a simplex.  Out: its centre, and whether it has one.
   Relative to the first corner a, with B, C, D the other corners and B2 = |B|^2 - (w_b - w_a), and so on,
       centre = (B2 CxD + C2 DxB + D2 BxC) / (2 B.CxD).
   The relative error is some 1e-15 L^3 / |B.CxD|, L the longest edge at a; below 1e-6 L^3 all is computed again in
   pairs of doubles, from exact differences, which leaves 1e-26 L^3 / |B.CxD|.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwc__job pbwc__job;
static void pbwc__job_start(pbwc__job *job, unsigned what, const pbw_options *options);
typedef struct pbwc__period pbwc__period;
typedef struct pbwc__clip pbwc__clip;
typedef struct pbwc__visit pbwc__visit;
typedef PBW_ARRAY(pbwc__visit) pbwc__visits;
#define PBWC__GOOD   1u                    /* the centre is right to 12 digits */
#define PBWC__INSIDE 2u                    /* it is in the domain, for certain */

typedef struct pbwc__centre {
    double x[3];                           /* relative to the simplex's first corner */
    pbw_index simplex;
    unsigned flags;                        /* PBWC__GOOD and so on, or'ed */
} pbwc__centre;
typedef PBW_ARRAY(pbwc__centre) pbwc__centres;

/* Returns whether doubles are enough for the centre.  det: 6 times the volume; largest: the largest squared edge at
   corner 0. */
PBW_INLINE int pbwc__is_thick3(double det, double largest)
{
    return det > 0 && det * det > 1e-12 * largest * largest * largest;
}

/* Returns 0 if the centre may be far off. */
PBW_INLINE int pbwc__centre_of(const pbw_mesh *mesh, size_t dim, pbw_index simplex, double *centre)
{
    const pbw_index *corner = mesh->simplices + simplex * (dim + 1);
    const double *a = mesh->points + corner[0] * dim, *w = mesh->weights, *at[4];
    double r[3][3], height[3], weight[4], largest = 0, det;
    size_t i, k;
    for (i = 0; i < dim; i++) {
        const double *b = mesh->points + corner[i + 1] * dim;
        height[i] = 0;
        for (k = 0; k < dim; k++) {
            r[i][k] = b[k] - a[k];
            height[i] += r[i][k] * r[i][k];
        }
        largest = height[i] > largest ? height[i] : largest;
        height[i] -= w != NULL ? w[corner[i + 1]] - w[corner[0]] : 0;
    }
    if (dim == 2) {
        det = r[0][0] * r[1][1] - r[0][1] * r[1][0];
        if (det > 1e-6 * largest) {
            centre[0] = (height[0] * r[1][1] - height[1] * r[0][1]) / (2 * det);
            centre[1] = (height[1] * r[0][0] - height[0] * r[1][0]) / (2 * det);
            return 1;
        }
    } else {
        double m[3][3];
        for (i = 0; i < 3; i++) {
            const double *p = r[(i + 1) % 3], *q = r[(i + 2) % 3];
            m[i][0] = p[1] * q[2] - p[2] * q[1];
            m[i][1] = p[2] * q[0] - p[0] * q[2];
            m[i][2] = p[0] * q[1] - p[1] * q[0];
        }
        det = r[0][0] * m[0][0] + r[0][1] * m[0][1] + r[0][2] * m[0][2];
        if (pbwc__is_thick3(det, largest)) {
            const double scale = 0.5 / det;
            for (k = 0; k < 3; k++) {
                centre[k] = (height[0] * m[0][k] + height[1] * m[1][k] + height[2] * m[2][k]) * scale;
            }
            return 1;
        }
    }
    for (i = 0; i <= dim; i++) {
        at[i] = mesh->points + corner[i] * dim;
        weight[i] = w != NULL ? w[corner[i]] : 0;
    }
    return pbw_centre((int)dim, at, w != NULL ? weight : NULL, centre);
}

/* ------------------------------------------------------------------------------------------------------
   >>exact        Exact numbers.
   A number is a sign and limbs of 32 bits: sign * sum of limb[i] * 2^(32 (low + i)); the first and the last limb are
   not 0.  Every double is one, and so are sums and products: nothing is rounded, over- or underflows.
   In: at most products of five coordinates or differences of two, and sums of a few hundred of them.  Out: signs.
   A double has bits from 2^-1074 to 2^1023, so five factors have less than 10,500 bits, 329 limbs; PBWC__LIMBS is
   enough for sums.
   ------------------------------------------------------------------------------------------------------ */
#define PBWC__LIMBS 336

typedef struct pbwc__exact { int sign, low, count; uint32_t limb[PBWC__LIMBS]; } pbwc__exact;

static void pbwc__trim(pbwc__exact *a)
{
    int zeros = 0;
    while (a->count > 0 && a->limb[a->count - 1] == 0) {
        a->count--;
    }
    while (zeros < a->count && a->limb[zeros] == 0) {
        zeros++;
    }
    memmove(a->limb, a->limb + zeros, (size_t)(a->count - zeros) * sizeof *a->limb);
    a->low += zeros;
    a->count -= zeros;
    a->sign = a->count > 0 ? a->sign : 0;
}

static void pbwc__exact_of(double x, pbwc__exact *a)
{
    int exponent, shift;
    const uint64_t bits = (uint64_t)ldexp(frexp(fabs(x), &exponent), 53);
    uint64_t low, high;
    exponent = exponent - 53 + 2048;                 /* above 0, so that the quotient is rounded down */
    shift = exponent % 32;
    low = (bits & 0xffffffffu) << shift;
    high = ((bits >> 32) << shift) + (low >> 32);
    a->sign = x > 0 ? 1 : -1;
    a->low = exponent / 32 - 64;
    a->count = 3;
    a->limb[0] = (uint32_t)(low & 0xffffffffu);
    a->limb[1] = (uint32_t)(high & 0xffffffffu);
    a->limb[2] = (uint32_t)(high >> 32);
    pbwc__trim(a);
}

PBW_INLINE uint32_t pbwc__limb(const pbwc__exact *a, int i)
{
    return i >= a->low && i < a->low + a->count ? a->limb[i - a->low] : 0;
}

/* Adds sign * b to a. */
static void pbwc__exact_add(pbwc__exact *a, const pbwc__exact *b, int sign)
{
    const pbwc__exact *more = a, *less = b;
    const int signs = a->sign * b->sign * sign;
    pbwc__exact sum;
    int from = a->low < b->low ? a->low : b->low, i;
    int to = a->low + a->count > b->low + b->count ? a->low + a->count : b->low + b->count;
    int64_t carry = 0;
    if (signs == 0) {
        if (a->sign == 0) {
            memcpy(a, b, offsetof(pbwc__exact, limb) + (size_t)b->count * sizeof *b->limb);
            a->sign *= sign;
        }
        return;
    }
    for (i = to; signs < 0 && i-- > from && more == a; ) {
        const uint32_t x = pbwc__limb(a, i), y = pbwc__limb(b, i);
        if (x != y) {
            more = x > y ? a : b;
            less = x > y ? b : a;
            break;
        }
    }
    sum.sign = more == a ? a->sign : b->sign * sign;
    sum.low = from;
    sum.count = to - from;
    for (i = from; i < to; i++) {
        carry += pbwc__limb(more, i);
        carry += signs * (int64_t)pbwc__limb(less, i);
        sum.limb[i - from] = (uint32_t)(carry & 0xffffffff);
        carry = carry < 0 ? -1 : carry >> 32;
    }
    if (carry > 0) {
        sum.limb[sum.count++] = (uint32_t)carry;
    }
    pbwc__trim(&sum);
    memcpy(a, &sum, offsetof(pbwc__exact, limb) + (size_t)sum.count * sizeof *sum.limb);
}

/* Adds sign * b * c to a. */
static void pbwc__exact_add_product(pbwc__exact *a, const pbwc__exact *b, const pbwc__exact *c, int sign)
{
    pbwc__exact product;
    int i, k;
    product.sign = b->sign * c->sign;
    product.low = b->low + c->low;
    product.count = product.sign != 0 ? b->count + c->count : 0;
    memset(product.limb, 0, (size_t)product.count * sizeof *product.limb);
    for (i = 0; i < b->count && product.sign != 0; i++) {
        uint64_t carry = 0;
        for (k = 0; k < c->count; k++) {
            carry += product.limb[i + k] + (uint64_t)b->limb[i] * c->limb[k];
            product.limb[i + k] = (uint32_t)(carry & 0xffffffffu);
            carry >>= 32;
        }
        product.limb[i + k] = (uint32_t)carry;
    }
    pbwc__trim(&product);
    pbwc__exact_add(a, &product, sign);
}

static void pbwc__exact_minus(double x, double y, pbwc__exact *a)
{
    pbwc__exact b;
    pbwc__exact_of(x, a);
    pbwc__exact_of(y, &b);
    pbwc__exact_add(a, &b, -1);
}

/* a d - b c. */
static void pbwc__exact_minor(const pbwc__exact *a, const pbwc__exact *b, const pbwc__exact *c, const pbwc__exact *d,
                              pbwc__exact *minor)
{
    minor->sign = minor->count = minor->low = 0;
    pbwc__exact_add_product(minor, a, d, 1);
    pbwc__exact_add_product(minor, b, c, -1);
}

/* Rounded. */
static double pbwc__exact_value(const pbwc__exact *a)
{
    double sum = 0;
    int i;
    for (i = 0; i < a->count; i++) {
        sum += ldexp(a->limb[i], 32 * (a->low + i));
    }
    return a->sign * sum;
}

/* ------------------------------------------------------------------------------------------------------
   >>polytopes    Polytopes, and cuts of them by planes.
   A polytope has corners, and facets as loops of corners, counter-clockwise from outside; in the plane one loop,
   of which the i-th edge, from corner i to the next, is facet i.
   Holds: each edge of a polytope in space is in two loops, once in each direction; so the surface is closed.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwc__poly {
    PBW_ARRAY(pbwc__vector) x;             /* the corners (in the plane the last number is 0); some in no loop */
    pbwc__indices name, start, loop;       /* per facet: the neighbour or wall, where its loop starts; the loops */
} pbwc__poly;

typedef struct pbwc__spot {                /* where three planes meet, by the names of their facets */
    pbw_index plane[3];
    int known;                             /* is what follows known? */
    double x[3], det, x_size[3], det_size; /* the place is x / det; sums of the sizes of their terms */
} pbwc__spot;

typedef struct pbwc__cutter {
    pbwc__poly poly, next;
    pbwc__doubles side;                    /* per corner: distance beyond the plane, scaled */
    pbwc__indices edges, cap;              /* cut edges: two corners and the new one; after each corner in the cap */
    PBW_ARRAY(pbwc__spot) spots;           /* per corner, where signs are exact; else there are none */
} pbwc__cutter;

#define PBWC__TINY 2.3e-308                /* a distance from a plane that is next to none */

static void pbwc__poly_clear(pbwc__poly *poly)
{
    poly->name.count = poly->start.count = poly->loop.count = 0;
}

static void pbwc__poly_release(pbw_memory *memory, pbwc__poly *poly)
{
    PBW_RELEASE(memory, poly->x);
    PBW_RELEASE(memory, poly->name);
    PBW_RELEASE(memory, poly->start);
    PBW_RELEASE(memory, poly->loop);
}

static void pbwc__cutter_release(pbw_memory *memory, pbwc__cutter *cutter)
{
    pbwc__poly_release(memory, &cutter->poly);
    pbwc__poly_release(memory, &cutter->next);
    PBW_RELEASE(memory, cutter->side);
    PBW_RELEASE(memory, cutter->edges);
    PBW_RELEASE(memory, cutter->cap);
    PBW_RELEASE(memory, cutter->spots);
}

static size_t pbwc__loop_end(const pbwc__poly *poly, size_t facet)
{
    return facet + 1 < poly->start.count ? poly->start.at[facet + 1] : poly->loop.count;
}

static int pbwc__begin_facet(pbw_memory *memory, pbwc__poly *poly, pbw_index name)
{
    return PBW_PUSH(memory, poly->start, (pbw_index)poly->loop.count) && PBW_PUSH(memory, poly->name, name);
}

/* The box with low and high corner, its walls named as in pbw_cells.neighbors. */
static int pbwc__poly_box(pbw_memory *memory, pbwc__poly *poly, int dim, const double *low, const double *high)
{
    static const unsigned char face[6][4] = { { 0, 4, 6, 2 }, { 1, 3, 7, 5 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 },
                                              { 0, 2, 3, 1 }, { 4, 5, 7, 6 } };
    static const unsigned char edge[4][2] = { { 0, 2 }, { 1, 1 }, { 3, 3 }, { 2, 0 } };     /* corner, wall */
    const unsigned corners = dim == 3 ? 8 : 4;
    unsigned i, k;
    pbwc__poly_clear(poly);
    poly->x.count = 0;
    if (!PBW_RESERVE(memory, poly->x, corners)) {
        return 0;
    }
    for (i = 0; i < corners; i++, poly->x.count++) {
        for (k = 0; k < 3; k++) {
            poly->x.at[i][k] = k == 2 && dim == 2 ? 0 : (i >> k & 1) != 0 ? high[k] : low[k];
        }
    }
    for (i = 0; dim == 3 && i < 24; i++) {
        if ((i % 4 == 0 && !pbwc__begin_facet(memory, poly, PBW_NONE - 1 - i / 4))
            || !PBW_PUSH(memory, poly->loop, face[i / 4][i % 4])) {
            return 0;
        }
    }
    for (i = 0; dim == 2 && i < 4; i++) {
        if (!pbwc__begin_facet(memory, poly, PBW_NONE - 1 - edge[i][1])
            || !PBW_PUSH(memory, poly->loop, edge[i][0])) {
            return 0;
        }
    }
    return 1;
}

/* Adds a corner where planes meet.  Returns 0 if there is no memory. */
static int pbwc__add_spot(pbw_memory *memory, pbwc__cutter *cutter, pbw_index a, pbw_index b, pbw_index c)
{
    pbwc__spot spot;
    spot.plane[0] = a;
    spot.plane[1] = b;
    spot.plane[2] = c;
    spot.known = 0;
    return PBW_PUSH(memory, cutter->spots, spot);
}

/* Returns the new corner on the edge from p to q of a facet, made at its first use; PBW_NONE if there is no memory.
   In space the edge is in two facets, and its second use tells the other one. */
static pbw_index pbwc__cut_edge(pbw_memory *memory, pbwc__cutter *cutter, pbw_index p, pbw_index q, pbw_index facet,
                                pbw_index name)
{
    const pbw_index low = p < q ? p : q, high = p < q ? q : p;
    const double *side = cutter->side.at;
    pbw_index *edge = cutter->edges.at;
    double t;
    size_t i;
    for (i = cutter->edges.count; i > 0; i -= 3) {
        if (edge[i - 3] == low && edge[i - 2] == high) {
            if (cutter->spots.count > 0) {
                cutter->spots.at[edge[i - 1]].plane[1] = facet;
            }
            return edge[i - 1];
        }
    }
    if (!PBW_RESERVE(memory, cutter->poly.x, 1) || !PBW_RESERVE(memory, cutter->edges, 3)
        || (cutter->spots.count > 0 && !pbwc__add_spot(memory, cutter, facet, PBW_NONE, name))) {
        return PBW_NONE;
    }
    t = side[low] / (side[low] - side[high]);
    for (i = 0; i < 3; i++) {
        const double a = cutter->poly.x.at[low][i], b = cutter->poly.x.at[high][i];
        cutter->poly.x.at[cutter->poly.x.count][i] = a + t * (b - a);
    }
    edge = cutter->edges.at + cutter->edges.count;
    edge[0] = low;
    edge[1] = high;
    edge[2] = (pbw_index)cutter->poly.x.count++;
    cutter->edges.count += 3;
    return edge[2];
}

/* Is a corner on the plane of the cut?  New ones are. */
static int pbwc__is_on(const pbwc__cutter *cutter, pbw_index corner)
{
    const double *side = cutter->side.at;
    return corner >= cutter->side.count || !(side[corner] < 0 || side[corner] > 0);
}

/* Cuts the loop of one facet in space, and notes its edges on the plane, which the cap has the other way round.
   Returns 0 if there is no memory. */
static int pbwc__cut_loop(pbw_memory *memory, pbwc__cutter *cutter, size_t facet, pbw_index name)
{
    const double *side = cutter->side.at;
    const size_t begin = cutter->poly.start.at[facet], end = pbwc__loop_end(&cutter->poly, facet);
    const pbw_index own = cutter->poly.name.at[facet];
    const pbw_index *loop = cutter->poly.loop.at;
    pbw_index *out;
    size_t i, count = 0;
    int inside = 0;
    for (i = begin; i < end; i++) {
        inside |= side[loop[i]] < 0;
    }
    if (!inside) {                                   /* at most an edge of it is left */
        return 1;
    }
    if (!PBW_RESERVE(memory, cutter->next.loop, 2 * (end - begin))
        || !pbwc__begin_facet(memory, &cutter->next, own)) {
        return 0;
    }
    out = cutter->next.loop.at + cutter->next.loop.count;
    for (i = begin; i < end; i++) {
        const pbw_index a = loop[i], b = loop[i + 1 < end ? i + 1 : begin];
        if (!(side[a] > 0)) {
            out[count++] = a;
        }
        if ((side[a] > 0 && side[b] < 0) || (side[a] < 0 && side[b] > 0)) {
            const pbw_index cut = pbwc__cut_edge(memory, cutter, a, b, own, name);
            if (cut == PBW_NONE) {
                return 0;
            }
            out[count++] = cut;
        }
    }
    if (!PBW_RESERVE(memory, cutter->cap, cutter->poly.x.count - cutter->cap.count)) {
        return 0;
    }
    while (cutter->cap.count < cutter->poly.x.count) {
        cutter->cap.at[cutter->cap.count++] = PBW_NONE;
    }
    for (i = 0; i < count; i++) {
        const pbw_index a = out[i], b = out[i + 1 < count ? i + 1 : 0];
        if (pbwc__is_on(cutter, a) && pbwc__is_on(cutter, b)) {
            cutter->cap.at[b] = a;
        }
    }
    cutter->next.loop.count += count;
    return 1;
}

/* In the plane: cuts the loop of all edges.  The edge of the cut starts where the loop leaves the half-plane. */
static int pbwc__cut_polygon(pbw_memory *memory, pbwc__cutter *cutter, pbw_index name)
{
    const double *side = cutter->side.at;
    const size_t count = cutter->poly.loop.count;
    size_t i;
    int inside = 0;
    for (i = 0; i < count; i++) {
        inside |= side[cutter->poly.loop.at[i]] < 0;
    }
    for (i = 0; i < count && inside; i++) {
        const pbw_index *loop = cutter->poly.loop.at;
        const pbw_index a = loop[i], b = loop[i + 1 < count ? i + 1 : 0], edge = cutter->poly.name.at[i];
        if (!(side[a] > 0)
            && (!pbwc__begin_facet(memory, &cutter->next, !(side[a] < 0) && side[b] > 0 ? name : edge)
                || !PBW_PUSH(memory, cutter->next.loop, a))) {
            return 0;
        }
        if ((side[a] > 0 && side[b] < 0) || (side[a] < 0 && side[b] > 0)) {
            const pbw_index cut = pbwc__cut_edge(memory, cutter, a, b, edge, name);
            if (cut == PBW_NONE || !pbwc__begin_facet(memory, &cutter->next, side[b] > 0 ? name : edge)
                || !PBW_PUSH(memory, cutter->next.loop, cut)) {
                return 0;
            }
        }
    }
    return 1;
}

/* Adds the facets that close a cut in space: cycles of corners on its plane, only one unless rounding has bent the
   surface. */
static int pbwc__cut_cap(pbw_memory *memory, pbwc__cutter *cutter, pbw_index name)
{
    pbw_index *after = cutter->cap.at, i, at, then;
    for (i = 0; i < cutter->cap.count; i++) {
        size_t from = cutter->next.loop.count;
        if (after[i] == PBW_NONE) {
            continue;
        }
        if (!pbwc__begin_facet(memory, &cutter->next, name)) {
            return 0;
        }
        for (at = i; after[at] != PBW_NONE; at = then) {
            if (!PBW_PUSH(memory, cutter->next.loop, at)) {
                return 0;
            }
            then = after[at];
            after[at] = PBW_NONE;
        }
        if (cutter->next.loop.count - from < 3) {
            cutter->next.loop.count = from;
            cutter->next.start.count--;
            cutter->next.name.count--;
        }
    }
    return 1;
}

/* Keeps the part whose corners are not beyond the plane, by their sides.  Returns 0 if there is no memory. */
static int pbwc__cut_by_sides(pbw_memory *memory, pbwc__cutter *cutter, int dim, pbw_index name)
{
    size_t i;
    pbwc__poly swap;
    cutter->side.count = cutter->poly.x.count;
    cutter->edges.count = cutter->cap.count = 0;
    pbwc__poly_clear(&cutter->next);
    if (dim == 2) {
        if (!pbwc__cut_polygon(memory, cutter, name)) {
            return 0;
        }
    } else {
        for (i = 0; i < cutter->poly.start.count; i++) {
            if (!pbwc__cut_loop(memory, cutter, i, name)) {
                return 0;
            }
        }
        if (!pbwc__cut_cap(memory, cutter, name)) {
            return 0;
        }
    }
    swap = cutter->poly;
    cutter->poly = cutter->next;
    cutter->next = swap;
    cutter->poly.x = cutter->next.x;                 /* corners are not moved */
    memset(&cutter->next.x, 0, sizeof cutter->next.x);
    return 1;
}

/* Keeps the part with n.x <= c, whose new facet gets the name.  Corners on the plane count as inside.  Returns 0 if
   there is no memory. */
static int pbwc__cut(pbw_memory *memory, pbwc__cutter *cutter, int dim, const double *plane, pbw_index name)
{
    const size_t count = cutter->poly.x.count;
    const double c = plane[dim];
    size_t i, outside = 0;
    double *side;
    cutter->side.count = cutter->spots.count = 0;
    if (!PBW_RESERVE(memory, cutter->side, count)) {
        return 0;
    }
    side = cutter->side.at;
    for (i = 0; i < count; i++) {
        const double *x = cutter->poly.x.at[i];
        side[i] = plane[0] * x[0] + plane[1] * x[1] + (dim == 3 ? plane[2] * x[2] : 0) - c;
        side[i] = side[i] < 0 || side[i] > 0 ? side[i] : -PBWC__TINY;
        outside += side[i] > 0;
    }
    return outside == 0 || pbwc__cut_by_sides(memory, cutter, dim, name);
}

/* ------------------------------------------------------------------------------------------------------
   >>stars        Stars: the simplices at a vertex v (in the plane, its parts), and their other vertices, the links.
   In: a vertex.  Out: its links, and the rings of simplices around them.
   In space the simplices at the edge from v to a link are its ring, counter-clockwise seen from the link.  A ring is
   walked from simplex to simplex: from v, u, p, q, positively oriented, the walk leaves across from p; q and the new
   corner are the next p and q.  A corner met for the first time is a new link, so the rings find all links.
   In the plane parts and links are counter-clockwise, and link i is between its parts `from` and `to`.
   The centres S T ... of a ring are the corners of the cell's facet towards the link.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwc__part { pbw_index simplex; double centre[3]; } pbwc__part;           /* centre: from v */
typedef struct pbwc__link {
    pbw_index vertex;
    pbw_index simplex, p, q;               /* in space: where its ring starts */
    size_t begin, count;                   /* its ring */
    int open;                              /* does it end at the hull? */
    pbw_index ends[2];                     /* of an open ring: the last corners of the hull facets there */
    int from, to;                          /* in the plane: parts, -1 beyond the hull */
    double d[3], foot;                     /* from v; the plane between the cells is at foot * d */
    double area;                           /* in space: of the facet */
    int listed;                            /* and: is it in the order of facets? */
} pbwc__link;

typedef struct pbwc__slot { uint32_t epoch; pbw_index key; int value; } pbwc__slot;
typedef struct pbwc__map { PBW_ARRAY(pbwc__slot) slots; size_t mask, count; uint32_t epoch; } pbwc__map;

PBW_INLINE size_t pbwc__slot_of(const pbwc__map *map, pbw_index key)
{
    const pbwc__slot *slots = map->slots.at;
    size_t i = (size_t)(key * 2654435761u >> 7) & map->mask;
    while (slots[i].epoch == map->epoch && slots[i].key != key) {
        i = (i + 1) & map->mask;
    }
    return i;
}

/* Doubles the slots of a map, or makes the first ones.  Returns 0 if there is no memory. */
static int pbwc__map_grow(pbw_memory *memory, pbwc__map *map)
{
    const size_t size = map->mask != 0 ? 2 * (map->mask + 1) : 256;
    const pbwc__slot *slots = map->slots.at;
    pbwc__map larger;
    size_t i;
    memset(&larger, 0, sizeof larger);
    if (!PBW_ZEROS(memory, larger.slots, size)) {
        return 0;
    }
    larger.mask = size - 1;
    larger.epoch = 1;
    for (i = 0; map->mask != 0 && i <= map->mask; i++) {
        if (slots[i].epoch == map->epoch) {
            pbwc__slot *slot = larger.slots.at + pbwc__slot_of(&larger, slots[i].key);
            *slot = slots[i];
            slot->epoch = 1;
            larger.count++;
        }
    }
    PBW_RELEASE(memory, map->slots);
    *map = larger;
    return 1;
}

/* Returns the number of a key, which becomes `fresh` if it had none; -1 if there is no memory. */
PBW_INLINE int pbwc__number(pbw_memory *memory, pbwc__map *map, pbw_index key, int fresh)
{
    pbwc__slot *slot;
    if (2 * map->count >= map->mask && !pbwc__map_grow(memory, map)) {
        return -1;
    }
    slot = map->slots.at + pbwc__slot_of(map, key);
    if (slot->epoch != map->epoch) {
        slot->epoch = map->epoch;
        slot->key = key;
        slot->value = fresh;
        map->count++;
    }
    return slot->value;
}

static void pbwc__map_clear(pbwc__map *map)
{
    map->epoch++;                                    /* a range has less than 2^32 points */
    map->count = 0;
}

#define PBWC__CENTRES 8192                 /* centres that a range keeps, by the low bits of their simplex */
#define PBWC__CHUNK   16384                /* simplices in a range */
#define PBWC__LEFTS   1024                 /* cells that are left, in a range of their own */

/* The other corners of a simplex, so that corner i followed by them is positively oriented. */
static const unsigned char pbwc__other3[4][3] = { { 1, 2, 3 }, { 0, 3, 2 }, { 3, 0, 1 }, { 2, 1, 0 } };

typedef struct pbwc__total { double sum[4]; pbw_index vertex; unsigned flags; } pbwc__total; /* moments, volume */
typedef PBW_ARRAY(pbwc__total) pbwc__totals;

typedef struct pbwc__range {               /* the cells of a range, in their order */
    pbwc__indices cells, neighbors, loop_counts, loops;              /* cells: their points */
    pbwc__doubles areas, vertices, rays;
    pbwc__totals totals;                   /* in space: of vertices that are shared or left */
} pbwc__range;

typedef struct pbwc__end { int side, leaves, visit; } pbwc__end;     /* of a chain, at a link */

typedef struct pbwc__corner {              /* of a loop; what it is known to be at, exactly: */
    double x[2];                           /* relative to the site */
    int part;                              /* the centre of a part, else -1 */
    pbw_index ring;                        /* a corner of the polygon, else PBW_NONE */
    pbw_index edge;                        /* what goes on from here: this edge, or if PBW_NONE */
    int link;                              /* the side to this link */
} pbwc__corner;

typedef struct pbwc__work {                /* of one range */
    pbwc__job *job;
    pbw_memory *memory;
    pbwc__range *out;
    PBW_ARRAY(pbwc__part) parts;           /* in the plane */
    PBW_ARRAY(pbwc__link) links;
    pbwc__indices rings;                   /* of all links, in space */
    pbwc__indices star, order;             /* in space: its simplices; for facets, its links in their order */
    pbwc__map numbers;                     /* of links, or of parts, by vertex or simplex */
    pbwc__cutter cutter;
    pbwc__centres centres;                 /* kept */
    pbw_index site;                        /* the vertex of the star */
    int open;                              /* is the star at the hull? */
    unsigned flags;                        /* those that all centres have */
    const pbwc__visit *visits;             /* of a polygon's edges in the cell */
    size_t visit_count;
    PBW_ARRAY(pbwc__end) ends;             /* of chains, in order */
    pbwc__sizes end_of;                    /* per visit: the ends at its begin and end */
    pbwc__bytes used;                      /* per visit: is it joined? */
    PBW_ARRAY(pbwc__corner) loop;
    pbwc__indices begins;                  /* of loops */
} pbwc__work;

#define PBWC__GRID 64

/* Copies that are searched one by one, where a grid is too coarse for them. */
typedef struct pbwc__copy { double shift[3]; pbw_index source; } pbwc__copy;
typedef struct pbwc__found { pbwc__copy copy; double depth; } pbwc__found;      /* source PBW_NONE: none was found;
                                                                       depth: radius^2 less its squared distance */

#define PBWC__BRANCHES 8u
#define PBWC__TREE_LEVELS 11u                        /* 8^11 points are more than indices have */

typedef struct pbwc__searched {
    int on;
    PBW_ARRAY(pbwc__copy) added;           /* copies that searches found, sorted */
    PBW_ARRAY(pbwc__found) found;          /* of this round: of each point's cell, then of each simplex */
    pbwc__indices order;                   /* points along a curve */
    pbwc__doubles boxes;                   /* low and high corners, 6 numbers, around 8 of them each, then around 8 of
                                              these each, and so on to one */
    size_t level[PBWC__TREE_LEVELS + 1], levels;     /* where boxes of a level begin */
    int axis[3];                           /* periods, the longest one last */
    double frame[3][3], step[3][3];        /* orthogonal directions of length 1, the first ones in the span of the
                                              first periods; periods along them */
    double low[3], high[3];                /* of the points along them */
} pbwc__searched;

struct pbwc__period {
    int dim, apexes;                       /* apexes: dim + 1 points far out, where the others are flat */
    unsigned axes;
    size_t count, total;                   /* points; with copies */
    pbw_memory *memory;
    int is_lattice;
    double vector[3][3], to_given[3][3];   /* of a lattice: reduced vectors, sums of so many of each given one */
    double normal[3][3];                   /* heights: along these, from the face of the other two; else along axes */
    double size[3], unit[3], margin[3];    /* of the box; all are multiples of the units; of the padded box; of a
                                              lattice sizes and margins are heights */
    double wall[3];                        /* half of the box around a site that has its cell for certain */
    double reach[3];                       /* no copy has larger coordinates */
    double low[3], high[3];                /* how far balls can reach */
    double grid[3], step[3];               /* the low corner of the grid, and its cells; those at its ends go on */
    double heaviest, lightest;             /* weight */
    double from[3], to[3];                 /* bounds of the marked part */
    pbwc__doubles x, w;
    pbwc__indices source;                  /* of each copy */
    pbwc__bytes marks;
    pbwc__bytes thin;                      /* per point: is it one of few that are copied far out?  NULL: none is */
    unsigned char marked;                  /* 1: new marks, or found copies, in this round */
    pbwc__searched searched;
};

struct pbwc__job {
    const pbw_mesh *mesh;
    pbw_mesh spanned;                      /* the mesh, where that of the caller has points but no simplex */
    pbw_memory memory;
    pbw_options options;                   /* of calls within this one, which share its limit of memory */
    pbwc__period *period;                  /* NULL: not periodic */
    pbwc__clip *clip;                      /* NULL: no polygon */
    unsigned what;
    int bounded, weighted;
    size_t count;                          /* cells: of the mesh's first points */
    double low[3], high[3], slack[3];      /* of the box, else infinite; slack: for its rounding */
    double from[3], to[3], extent[3];      /* a box around the domain */
    int exponent;                          /* of the largest extent */
    const double *planes;                  /* of the domain: normal and offset */
    size_t plane_count;
    pbwc__poly domain;
    pbwc__indices merged;                  /* per simplex: the first one with its centre at the same place */
    PBW_ARRAY(pbwc__range) ranges;
    pbw_cells *cells;
    double *volumes, *centroids;
    double *vertices;                      /* with shapes: first the centres of all simplices */
    size_t *first;
    pbwc__sizes entries;                   /* with shapes, per point: where its loops' entries begin */
    pbwc__bytes cut;                       /* per point: was its cell cut? */
    pbwc__bytes states;                    /* in space: flags of each point's totals */
    pbwc__indices left;                    /* and cells left for stars */
    pbwc__doubles parts;                   /* for facets in space: of each simplex, its parts of six facets' areas */
};


static int pbwc__centres_new(pbw_memory *memory, pbwc__centres *centres)
{
    size_t i;
    if (!PBW_FIT(memory, *centres, PBWC__CENTRES)) {
        return 0;
    }
    for (i = 0; i < PBWC__CENTRES; i++) {
        centres->at[i].simplex = PBW_NONE;
    }
    return 1;
}

/* Returns whether a + x is certainly in all half-spaces of the domain.  radius: sum of |x|. */
static int pbwc__in_planes(const pbwc__job *job, const double *a, const double *x, double radius)
{
    const size_t dim = (size_t)job->mesh->dim;
    const double *plane = job->planes;
    int inside = 1;
    size_t i, k;
    for (i = 0; i < job->plane_count; i++, plane += dim + 1) {
        double beyond = -plane[dim], size = fabs(plane[dim]), normal = 0;
        for (k = 0; k < dim; k++) {
            const double at = plane[k] * a[k];
            beyond += at + plane[k] * x[k];
            size += fabs(at);
            normal += fabs(plane[k]);
        }
        inside &= beyond < -1e-12 * (normal * radius) - 1e-14 * size;
    }
    return inside;
}

static void pbwc__centre_of_flat(const pbw_mesh *mesh, pbw_index simplex, double *centre);

/* Returns whether a + x is certainly in the domain. */
PBW_INLINE int pbwc__inside(const pbwc__job *job, size_t dim, const double *a, const double *x)
{
    double radius = 0;
    size_t k;
    int inside = 1;
    for (k = 0; k < dim; k++) {
        radius += fabs(x[k]);
    }
    for (k = 0; k < dim; k++) {                      /* if in doubt, cut */
        const double at = a[k] + x[k], slack = 1e-12 * radius + job->slack[k];
        inside &= (at - job->low[k] > slack) & (job->high[k] - at > slack);
    }
    return inside && (job->plane_count == 0 || pbwc__in_planes(job, a, x, radius));
}

PBW_INLINE void pbwc__make_centre(const pbwc__job *job, size_t dim, pbw_index simplex, pbwc__centre *centre)
{
    const double *a = job->mesh->points + job->mesh->simplices[simplex * (dim + 1)] * dim;
    centre->simplex = simplex;
    centre->flags = pbwc__centre_of(job->mesh, dim, simplex, centre->x) ? PBWC__GOOD | PBWC__INSIDE : 0;
    if (centre->flags == 0 && job->clip != NULL) {
        pbwc__centre_of_flat(job->mesh, simplex, centre->x);
    }
    if (!pbwc__inside(job, dim, a, centre->x)) {
        centre->flags &= ~PBWC__INSIDE;
    }
}

static void pbwc__make_centre2(const pbwc__job *job, pbw_index simplex, pbwc__centre *centre)
{
    pbwc__make_centre(job, 2, simplex, centre);
}

static void pbwc__make_centre3(const pbwc__job *job, pbw_index simplex, pbwc__centre *centre)
{
    pbwc__make_centre(job, 3, simplex, centre);
}

/* Sets x to the centre of a simplex relative to the site.  It is cached, as other stars need it too.  Returns its
   flags. */
PBW_INLINE unsigned pbwc__from_site(const pbwc__job *job, pbwc__centre *centres, size_t dim,
                                    const double *site, pbw_index simplex, double *x)
{
    const double *a = job->mesh->points + job->mesh->simplices[simplex * (dim + 1)] * dim;
    pbwc__centre *centre = centres + simplex % PBWC__CENTRES;
    size_t k;
    if (centre->simplex != simplex) {
        (dim == 3 ? pbwc__make_centre3 : pbwc__make_centre2)(job, simplex, centre);
    }
    for (k = 0; k < dim; k++) {
        x[k] = centre->x[k] + (a[k] - site[k]);
    }
    return centre->flags;
}

/* Adds a link with its bisector.  Returns NULL if there is no memory. */
PBW_INLINE pbwc__link *pbwc__add_link(pbwc__work *work, size_t dim, pbw_index vertex)
{
    const pbw_mesh *mesh = work->job->mesh;
    const pbw_index v = work->site;
    pbwc__link *link;
    double square = 0;
    size_t k;
    if (!PBW_RESERVE(work->memory, work->links, 1)) {
        return NULL;
    }
    link = work->links.at + work->links.count++;
    link->vertex = vertex;
    link->open = link->listed = 0;
    link->d[2] = link->area = 0;
    for (k = 0; k < dim; k++) {
        link->d[k] = mesh->points[vertex * dim + k] - mesh->points[v * dim + k];
        square += link->d[k] * link->d[k];
    }
    link->foot = 0.5;
    if (mesh->weights != NULL) {
        link->foot += (mesh->weights[v] - mesh->weights[vertex]) / (2 * square);
    }
    return link;
}

/* ---- in space */

/* The simplex beyond the facet across from a corner. */
PBW_INLINE pbw_index pbwc__across(const pbw_mesh *mesh, pbw_index simplex, pbw_index vertex)
{
    const pbw_index *corner = mesh->simplices + 4 * (size_t)simplex;
    const unsigned i = (corner[1] == vertex) + 2u * (corner[2] == vertex) + 3u * (corner[3] == vertex);
    return mesh->neighbors[4 * (size_t)simplex + i];
}

PBW_INLINE void pbwc__prefetch(const pbw_mesh *mesh, pbw_index simplex)
{
    const size_t at = simplex < mesh->simplex_count ? 4 * (size_t)simplex : 0;
    PBW_PREFETCH(mesh->simplices + at);
    PBW_PREFETCH(mesh->neighbors + at);
}

/* Returns the fourth corner; others: the other three, xor'ed. */
PBW_INLINE pbw_index pbwc__fourth(const pbw_mesh *mesh, pbw_index simplex, pbw_index others)
{
    const pbw_index *corner = mesh->simplices + 4 * (size_t)simplex;
    return corner[0] ^ corner[1] ^ corner[2] ^ corner[3] ^ others;
}

/* Adds a link with a ring that starts at the simplex of the site, the vertex, p and q, positively oriented.  Returns
   0 if there is no memory. */
static int pbwc__new_link3(pbwc__work *work, pbw_index vertex, pbw_index simplex, pbw_index p, pbw_index q)
{
    const int number = (int)work->links.count;
    pbwc__link *link = pbwc__add_link(work, 3, vertex);
    if (link == NULL || pbwc__number(work->memory, &work->numbers, vertex, number) < 0) {
        return 0;
    }
    link->simplex = simplex;
    link->p = p;
    link->q = q;
    return 1;
}

PBW_INLINE int pbwc__is_known(const pbwc__map *map, pbw_index key)
{
    return map->slots.at[pbwc__slot_of(map, key)].epoch == map->epoch;
}

PBW_INLINE void pbwc__cross(const double *s, const double *t, double *x)
{
    x[0] = s[1] * t[2] - s[2] * t[1];
    x[1] = s[2] * t[0] - s[0] * t[2];
    x[2] = s[0] * t[1] - s[1] * t[0];
}

/* Walks from a simplex around the edge from the site to u, back to it or to the hull.  Notes the simplices and new
   links.  at: simplex, p and q; updated.  Returns 1 if the walk came back, 0 at the hull, -1 if there is no memory.
   */
PBW_INLINE int pbwc__walk(pbwc__work *work, pbw_index u, pbw_index at[3])
{
    const pbw_mesh *mesh = work->job->mesh;
    const pbw_index edge = work->site ^ u, first = at[0];
    pbw_index simplex = first, p = at[1], q = at[2], next;
    for (;;) {
        next = pbwc__across(mesh, simplex, p);
        pbwc__prefetch(mesh, pbwc__across(mesh, simplex, u));    /* other rings will come there */
        if (!PBW_PUSH(work->memory, work->rings, simplex)
            || (u < p && u < q && !PBW_PUSH(work->memory, work->star, simplex))      /* one of its three rings */
            || (!pbwc__is_known(&work->numbers, q) && !pbwc__new_link3(work, q, simplex, u, p))) {
            return -1;
        }
        if (next == PBW_NONE || next == first) {
            break;
        }
        simplex = next;
        p = q;
        q = pbwc__fourth(mesh, simplex, edge ^ q);
    }
    at[0] = simplex;
    at[1] = p;
    at[2] = q;
    return next == first;
}

/* Walks the ring of a link, an open one from its first simplex to its last.  Returns 0 if there is no memory. */
static int pbwc__walk_ring(pbwc__work *work, size_t number)
{
    const pbw_mesh *mesh = work->job->mesh;
    pbwc__link *link = work->links.at + number;
    const pbw_index u = link->vertex, edge = work->site ^ u;
    const size_t begin = work->rings.count, before = work->star.count;
    pbw_index at[3], low = PBW_NONE, next;
    int closed;
    at[0] = link->simplex;
    at[1] = link->p;
    at[2] = link->q;
    closed = pbwc__walk(work, u, at);
    if (closed == 0) {                               /* back to the hull at the other end, then again from there */
        work->open = 1;
        work->rings.count = begin;
        work->star.count = before;
        while ((next = pbwc__across(mesh, at[0], at[2])) != PBW_NONE) {
            at[0] = next;
            at[2] = at[1];
            at[1] = pbwc__fourth(mesh, next, edge ^ at[1]);
        }
        low = at[1];
        if ((!pbwc__is_known(&work->numbers, low) && !pbwc__new_link3(work, low, at[0], at[2], u))
            || pbwc__walk(work, u, at) < 0) {
            return 0;
        }
    }
    link = work->links.at + number;                  /* new links may have moved it */
    link->begin = begin;
    link->count = work->rings.count - begin;
    link->open = closed == 0;
    link->ends[0] = low;
    link->ends[1] = at[2];
    return closed >= 0;
}

/* The simplices of a closed star, without links.  Returns 0 if there is no memory. */
static int pbwc__gather_simplices(pbwc__work *work)
{
    const pbw_mesh *mesh = work->job->mesh;
    const pbw_index v = work->site;
    size_t i, k;
    pbwc__map_clear(&work->numbers);
    if (!PBW_PUSH(work->memory, work->star, mesh->incident[v])
        || pbwc__number(work->memory, &work->numbers, mesh->incident[v], 0) < 0) {
        return 0;
    }
    for (i = 0; i < work->star.count; i++) {
        const size_t at = 4 * (size_t)work->star.at[i];
        for (k = 0; k < 4; k++) {
            const pbw_index next = mesh->neighbors[at + k];
            if (mesh->simplices[at + k] != v && !pbwc__is_known(&work->numbers, next)) {
                pbwc__prefetch(mesh, next);
                if (!PBW_PUSH(work->memory, work->star, next)
                    || pbwc__number(work->memory, &work->numbers, next, 0) < 0) {
                    return 0;
                }
            }
        }
    }
    pbwc__map_clear(&work->numbers);
    return 1;
}

static int pbwc__gather3(pbwc__work *work)
{
    const pbw_index simplex = work->job->mesh->incident[work->site];
    const pbw_index *corner = work->job->mesh->simplices + 4 * (size_t)simplex;
    const unsigned char *other;
    size_t i;
    pbwc__map_clear(&work->numbers);
    for (i = 0; corner[i] != work->site; i++) {
    }
    other = pbwc__other3[i];
    if (!pbwc__new_link3(work, corner[other[0]], simplex, corner[other[1]], corner[other[2]])) {
        return 0;
    }
    for (i = 0; i < work->links.count; i++) {
        if (!pbwc__walk_ring(work, i)) {
            return 0;
        }
    }
    return 1;
}

/* ---- in the plane */

/* Returns which corner of a triangle v is; the next triangle counter-clockwise around v is across from the corner
   after it. */
PBW_INLINE unsigned pbwc__corner2(const pbw_mesh *mesh, pbw_index simplex, pbw_index v)
{
    const pbw_index *corner = mesh->simplices + 3 * (size_t)simplex;
    return (corner[1] == v) + 2u * (corner[2] == v);
}

/* The parts of v, counter-clockwise, in a star at the hull from there.  Returns 0 if there is no memory. */
static int pbwc__gather2(pbwc__work *work)
{
    const pbw_mesh *mesh = work->job->mesh;
    const pbw_index v = work->site;
    const double *site = mesh->points + 2 * (size_t)v;
    pbw_index first = mesh->incident[v], at, next = PBW_NONE;
    int round;
    for (round = 0; round < 2 && next == PBW_NONE; round++) {
        work->parts.count = 0;
        at = first;
        do {
            pbwc__part *part;
            if (!PBW_RESERVE(work->memory, work->parts, 1)) {
                return 0;
            }
            part = work->parts.at + work->parts.count++;
            next = mesh->neighbors[3 * (size_t)at + (pbwc__corner2(mesh, at, v) + 1) % 3];
            part->simplex = at;
            work->flags &= pbwc__from_site(work->job, work->centres.at, 2, site, at, part->centre);
            at = next;
        } while (at != PBW_NONE && at != first);
        while (round == 0 && next == PBW_NONE        /* back to the hull at the other end, then again from there */
               && (at = mesh->neighbors[3 * (size_t)first + (pbwc__corner2(mesh, first, v) + 2) % 3]) != PBW_NONE) {
            first = at;
        }
    }
    work->open = next == PBW_NONE;
    return 1;
}

/* The link of a part before (0) or after (1) it, between parts from and to.  Returns 0 if there is no memory. */
static int pbwc__add_side(pbwc__work *work, size_t part, unsigned after, int from, int to)
{
    const pbw_mesh *mesh = work->job->mesh;
    const pbw_index simplex = work->parts.at[part].simplex;
    const unsigned corner = (pbwc__corner2(mesh, simplex, work->site) + 1 + after) % 3;
    pbwc__link *link = pbwc__add_link(work, 2, mesh->simplices[3 * (size_t)simplex + corner]);
    if (link == NULL) {
        return 0;
    }
    link->from = from;
    link->to = to;
    link->open = from < 0 || to < 0;
    return 1;
}

/* The links, in the plane.  Returns 0 if there is no memory. */
static int pbwc__add_sides(pbwc__work *work)
{
    const size_t count = work->parts.count;
    size_t i;
    if (work->open && !pbwc__add_side(work, 0, 0, -1, 0)) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        if (!pbwc__add_side(work, i, 1, (int)i, i + 1 < count ? (int)i + 1 : work->open ? -1 : 0)) {
            return 0;
        }
    }
    return 1;
}

/* Starts with the star of v. */
PBW_INLINE void pbwc__start_star(pbwc__work *work, pbw_index v)
{
    work->parts.count = work->rings.count = work->links.count = work->star.count = 0;
    work->site = v;
    work->open = 0;
    work->flags = PBWC__GOOD | PBWC__INSIDE;
}

/* Gathers the star of v; in the plane with its links only if asked.  Returns 0 if there is no memory. */
PBW_INLINE int pbwc__gather_some(pbwc__work *work, pbw_index v, int links)
{
    pbwc__start_star(work, v);
    return work->job->mesh->dim == 3 ? pbwc__gather3(work) : pbwc__gather2(work) && (!links || pbwc__add_sides(work));
}

static int pbwc__gather(pbwc__work *work, pbw_index v)
{
    return pbwc__gather_some(work, v, 1);
}

/* Prepares the work on a range.  Returns 0 if there is no memory; pbwc__work_end is due in any case. */
static int pbwc__work_start(pbwc__work *work, pbwc__job *job)
{
    memset(work, 0, sizeof *work);
    work->job = job;
    work->memory = &job->memory;
    return pbwc__centres_new(work->memory, &work->centres) && pbwc__map_grow(work->memory, &work->numbers);
}

static void pbwc__work_end(pbwc__work *work)
{
    PBW_RELEASE(work->memory, work->centres);
    PBW_RELEASE(work->memory, work->parts);
    PBW_RELEASE(work->memory, work->rings);
    PBW_RELEASE(work->memory, work->star);
    PBW_RELEASE(work->memory, work->order);
    PBW_RELEASE(work->memory, work->links);
    PBW_RELEASE(work->memory, work->numbers.slots);
    PBW_RELEASE(work->memory, work->ends);
    PBW_RELEASE(work->memory, work->end_of);
    PBW_RELEASE(work->memory, work->used);
    PBW_RELEASE(work->memory, work->loop);
    PBW_RELEASE(work->memory, work->begins);
    pbwc__cutter_release(work->memory, &work->cutter);
}

/* Returns the root of s in a union-find forest, and shortens the path.  Each item points to an earlier one, a root to
   itself. */
static pbw_index pbwc__root(pbw_index *merged, pbw_index s)
{
    while (merged[s] != s) {
        merged[s] = merged[merged[s]];
        s = merged[s];
    }
    return s;
}

/* ------------------------------------------------------------------------------------------------------
   >>volumes      Volumes and centroids of cells from their stars.
   In: a star.  Out: the moments of its cell, if it is closed and inside of the domain.
   The edge ST of a ring adds to the cell the tetrahedron of v, F, S and T, where F is where the facet's plane meets
   the line d from v to the link: 6 times its signed volume is foot d.(S x T).  In the plane it adds the triangle
   v S T.
   ------------------------------------------------------------------------------------------------------ */
/* Ends the sums of a cell: moments * 24 (in the plane 6), volume * 6 (2). */
static void pbwc__set_cell(pbwc__job *job, pbw_index v, const double *sum)
{
    const size_t dim = (size_t)job->mesh->dim;
    size_t k;
    job->volumes[v] = sum[3] > 0 ? sum[3] / (dim == 3 ? 6 : 2) : 0;
    for (k = 0; k < dim; k++) {
        const double site = job->mesh->points[v * dim + k];
        job->centroids[v * dim + k] = sum[3] > 0 ? site + sum[k] / (sum[3] * (dim == 3 ? 4 : 3)) : site;
    }
}

/* Adds the cells' parts of the rings of all links to sum.  Clears flags that a centre does not have. */
static void pbwc__sum_star3(pbwc__work *work, double *sum)
{
    const pbwc__job *job = work->job;
    const double *site = job->mesh->points + 3 * (size_t)work->site;
    size_t u, i;
    int k;
    for (u = 0; u < work->links.count; u++) {
        const pbwc__link *link = work->links.at + u;
        const pbw_index *ring = work->rings.at + link->begin;
        double moment[3] = { 0, 0, 0 }, along = 0, s[3], t[3], across[3], w;
        work->flags &= pbwc__from_site(job, work->centres.at, 3, site, ring[0], s);
        for (i = 1; i <= link->count; i++) {
            work->flags &= pbwc__from_site(job, work->centres.at, 3, site, ring[i < link->count ? i : 0], t);
            pbwc__cross(s, t, across);
            w = link->d[0] * across[0] + link->d[1] * across[1] + link->d[2] * across[2];
            along += w;
            for (k = 0; k < 3; k++) {
                moment[k] += w * (s[k] + t[k]);
                s[k] = t[k];
            }
        }
        for (k = 0; k < 3; k++) {
            sum[k] += link->foot * (moment[k] + along * (link->foot * link->d[k]));
        }
        sum[3] += link->foot * along;
    }
}

static void pbwc__sum_star2(const pbwc__work *work, double *sum)
{
    const pbwc__part *part = work->parts.at;
    const size_t count = work->parts.count;
    size_t i;
    for (i = 0; i < count; i++) {
        const double *s = part[i].centre, *t = part[i + 1 < count ? i + 1 : 0].centre;
        const double w = s[0] * t[1] - s[1] * t[0];
        sum[0] += w * (s[0] + t[0]);
        sum[1] += w * (s[1] + t[1]);
        sum[3] += w;
    }
}

/* If the domain does not cut the star's cell, sets its volume and centroid, infinite if it is open, and returns 1. */
static int pbwc__star_volume(pbwc__work *work)
{
    pbwc__job *job = work->job;
    const size_t dim = (size_t)job->mesh->dim, v = work->site;
    double sum[4] = { 0, 0, 0, 0 };
    if (job->bounded && work->open) {
        return 0;
    }
    if (dim == 2) {
        pbwc__sum_star2(work, sum);
    } else {
        pbwc__sum_star3(work, sum);
    }
    if (job->bounded && job->clip == NULL && (work->flags & PBWC__INSIDE) == 0) {
        return 0;
    }
    pbwc__set_cell(job, work->site, sum);
    if (work->open) {
        memcpy(job->centroids + v * dim, job->mesh->points + v * dim, dim * sizeof(double));
        job->volumes[v] = HUGE_VAL;
    }
    return 1;
}

/* ------------------------------------------------------------------------------------------------------
   >>totals       Volumes and centroids in space: one pass over the simplices, without stars.
   In: a mesh.  Out: volumes and centroids of cells that the domain does not cut; which ones it may cut.
   A simplex adds to the cells of its corners.  Let S be its centre, F the foot of S on the facet i j k, and M where
   the plane between the cells crosses the edge i j.  Cell i gets the signed tetrahedron i M F S; those of all
   simplices at i fill its cell.  With n the facet's inward normal, as long as twice its area,
       drop = (S - i).n / |n|^2,  F = S - drop n,
       6 times the volume = |iM| / |ij| G drop,
       2 G = |ij|^2 (i-k).(j-k) - |ij|^2 (w_k-w_i) + (j-i).(k-i) (w_j-w_i).
   So the triangle M F S, a part of the facet between i and j, has the area G drop / (2 |ij|).
   G / |n|^2 is F's barycentric coordinate at k.  The three G of a facet add up to |n|^2, and the four (S - i).n to 6
   times the simplex, wherever S is: volumes are whole even where S is rounded badly.
   A chunk of simplices has a sum for each of its vertices.  A vertex is shared if a facet at it leads to another
   chunk; then the sums of its chunks are added in the order of the chunks.
   Holds: which sums are added, and in which order, depends on the mesh alone.
   ------------------------------------------------------------------------------------------------------ */
#if defined(__GNUC__)
#define PBWC__LANES 2                      /* simplices at a time */
typedef double pbwc__lanes __attribute__((vector_size(16)));
#else
#define PBWC__LANES 1
typedef double pbwc__lanes;
#endif

#define PBWC__SHARED 1u                    /* a vertex: it is shared */
#define PBWC__LEFT   2u                    /* its cell is not the star's, or unbounded */
#define PBWC__ADDED  4u                    /* the sum of its first chunk has been added */
#define PBWC__LISTED 8u                    /* it is done, or listed for its star */

typedef struct pbwc__adder {               /* of one chunk */
    pbwc__job *job;
    pbwc__map numbers;                     /* of totals, by vertex */
    pbwc__totals totals;
} pbwc__adder;

typedef struct pbwc__simplex_geometry {    /* of simplices; edges 01 02 03 12 13 23; facets: across from corners */
    pbwc__lanes edge[6][3], square[6], weight[4];
    pbwc__lanes foot[6];                   /* |iM| / |ij| */
    pbwc__lanes given[6];                  /* G drop, of both facets at the edge */
    pbwc__lanes normal[4][3], drop[4];
    pbwc__lanes to[4][3];                  /* from the corners to the centre */
    pbwc__lanes sum[4][4];                 /* per corner: moments * 24, volume * 6 */
} pbwc__simplex_geometry;

static const int pbwc__ends[6][2] = { { 0, 1 }, { 0, 2 }, { 0, 3 }, { 1, 2 }, { 1, 3 }, { 2, 3 } };

PBW_INLINE pbwc__lanes pbwc__dot(const pbwc__lanes *a, const pbwc__lanes *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

PBW_INLINE void pbwc__cross_lanes(const pbwc__lanes *s, const pbwc__lanes *t, pbwc__lanes *x)
{
    x[0] = s[1] * t[2] - s[2] * t[1];
    x[1] = s[2] * t[0] - s[0] * t[2];
    x[2] = s[0] * t[1] - s[1] * t[0];
}

/* Edges, and with weights feet, of simplices from..from+LANES-1, of which `last` is the last. */
PBW_INLINE void pbwc__load(const pbw_mesh *mesh, int weighted, size_t from, size_t last,
                           pbwc__simplex_geometry *geometry)
{
    double x[4][4][PBWC__LANES];
    pbwc__lanes at[4][4];
    size_t e, i, k;
    for (i = 0; i < 4; i++) {
        for (k = 0; k < PBWC__LANES; k++) {
            const pbw_index v = mesh->simplices[4 * (from + k < last ? from + k : last) + i];
            x[i][0][k] = mesh->points[3 * (size_t)v];
            x[i][1][k] = mesh->points[3 * (size_t)v + 1];
            x[i][2][k] = mesh->points[3 * (size_t)v + 2];
            x[i][3][k] = weighted ? mesh->weights[v] : 0;
        }
    }
    memcpy(at, x, sizeof at);
    for (e = 0; e < 6; e++) {
        const int i0 = pbwc__ends[e][0], i1 = pbwc__ends[e][1];
        for (k = 0; k < 3; k++) {
            geometry->edge[e][k] = at[i1][k] - at[i0][k];
        }
        geometry->square[e] = pbwc__dot(geometry->edge[e], geometry->edge[e]);
        geometry->given[e] = geometry->square[e] - geometry->square[e];
        if (weighted) {
            geometry->foot[e] = 0.5 + (at[i0][3] - at[i1][3]) / (2 * geometry->square[e]);
        }
    }
    for (i = 0; i < 4; i++) {
        geometry->weight[i] = at[i][3];
    }
}

/* Normals, and to[0], the centre as in pbwc__centre_of.  Returns 6 times the volume. */
PBW_INLINE pbwc__lanes pbwc__find_centre(pbwc__simplex_geometry *geometry, int weighted)
{
    pbwc__lanes height[3], det;
    int i, k;
    for (i = 0; i < 3; i++) {
        pbwc__cross_lanes(geometry->edge[(i + 1) % 3], geometry->edge[(i + 2) % 3], geometry->normal[i + 1]);
        height[i] = geometry->square[i];
        if (weighted) {
            height[i] -= geometry->weight[i + 1] - geometry->weight[0];
        }
    }
    det = pbwc__dot(geometry->edge[0], geometry->normal[1]);
    for (k = 0; k < 3; k++) {
        geometry->normal[0][k] = -(geometry->normal[1][k] + geometry->normal[2][k] + geometry->normal[3][k]);
        geometry->to[0][k] = (height[0] * geometry->normal[1][k] + height[1] * geometry->normal[2][k]
                              + height[2] * geometry->normal[3][k]) * (0.5 / det);
    }
    return det;
}

/* Adds the contributions of facet f with corners i, j, k; edges: ij, ik, jk. */
PBW_INLINE void pbwc__add_facet(pbwc__simplex_geometry *geometry, int weighted, int f, const int corner[3],
                                const int edge[3])
{
    const pbwc__lanes *ij = geometry->edge[edge[0]], *ik = geometry->edge[edge[1]], *jk = geometry->edge[edge[2]];
    const pbwc__lanes *square = geometry->square, half = 0.5 * geometry->drop[f];
    pbwc__lanes at[3], g[3], part[3];
    int i, k;
    at[0] = pbwc__dot(ij, ik);
    at[1] = -pbwc__dot(ij, jk);
    at[2] = pbwc__dot(ik, jk);
    g[0] = square[edge[0]] * at[2];
    g[1] = square[edge[1]] * at[1];
    g[2] = square[edge[2]] * at[0];
    if (weighted) {
        const pbwc__lanes *w = geometry->weight;
        const pbwc__lanes wj = w[corner[1]] - w[corner[0]], wk = w[corner[2]] - w[corner[0]];
        g[0] -= square[edge[0]] * wk - at[0] * wj;
        g[1] -= square[edge[1]] * wj - at[0] * wk;
        g[2] += square[edge[2]] * wj + at[1] * (wk - wj);
    }
    for (i = 0; i < 3; i++) {
        g[i] *= half;
        geometry->given[edge[i]] += g[i];
    }
    if (weighted) {
        const pbwc__lanes *foot = geometry->foot;
        part[0] = foot[edge[0]] * g[0] + foot[edge[1]] * g[1];
        part[1] = (1 - foot[edge[0]]) * g[0] + foot[edge[2]] * g[2];
        part[2] = (1 - foot[edge[1]]) * g[1] + (1 - foot[edge[2]]) * g[2];
    } else {
        part[0] = 0.5 * (g[0] + g[1]);
        part[1] = 0.5 * (g[0] + g[2]);
        part[2] = 0.5 * (g[1] + g[2]);
    }
    for (i = 0; i < 3; i++) {
        pbwc__lanes *sum = geometry->sum[corner[i]];
        const pbwc__lanes drop = part[i] * geometry->drop[f];
        for (k = 0; k < 3; k++) {
            sum[k] -= drop * geometry->normal[f][k];
        }
        sum[3] += part[i];
    }
}

/* Computes the contributions of simplices; to[0] is set. */
PBW_INLINE void pbwc__sum_corners(pbwc__simplex_geometry *geometry, int weighted)
{
    static const int corners[4][3] = { { 1, 2, 3 }, { 0, 2, 3 }, { 0, 1, 3 }, { 0, 1, 2 } };
    static const int edges[4][3] = { { 3, 4, 5 }, { 1, 2, 5 }, { 0, 2, 4 }, { 0, 1, 3 } };
    int e, i, k;
    memset(geometry->sum, 0, sizeof geometry->sum);
    for (i = 0; i < 4; i++) {
        for (k = 0; k < 3 && i > 0; k++) {
            geometry->to[i][k] = geometry->to[0][k] - geometry->edge[i - 1][k];
        }
    }
    for (i = 0; i < 4; i++) {
        geometry->drop[i] = pbwc__dot(geometry->to[i == 0], geometry->normal[i])
                         / pbwc__dot(geometry->normal[i], geometry->normal[i]);
        pbwc__add_facet(geometry, weighted, i, corners[i], edges[i]);
    }
    for (e = 0; e < 6; e++) {
        pbwc__lanes first = 0.25 * geometry->given[e], second = first;
        if (weighted) {
            first = geometry->given[e] * geometry->foot[e] * geometry->foot[e];
            second = geometry->given[e] * (1 - geometry->foot[e]) * (1 - geometry->foot[e]);
        }
        for (k = 0; k < 3; k++) {
            geometry->sum[pbwc__ends[e][0]][k] += first * geometry->edge[e][k];
            geometry->sum[pbwc__ends[e][1]][k] -= second * geometry->edge[e][k];
        }
    }
    for (i = 0; i < 4; i++) {
        for (k = 0; k < 3; k++) {
            geometry->sum[i][k] += 2 * geometry->sum[i][3] * geometry->to[i][k];
        }
    }
}

typedef struct pbwc__contribution {
    double sum[4][4][PBWC__LANES], given[6][PBWC__LANES], square[6][PBWC__LANES];
    unsigned flags[PBWC__LANES];
} pbwc__contribution;

/* Computes the contributions of simplices from..from+LANES-1, the last one `last`, and the flags of their centres. */
PBW_INLINE void pbwc__contribute(const pbwc__job *job, int weighted, size_t from, size_t last,
                                 pbwc__contribution *contribution)
{
    const pbw_mesh *mesh = job->mesh;
    pbwc__simplex_geometry geometry;
    double x[3][PBWC__LANES], det[PBWC__LANES], (*square)[PBWC__LANES] = contribution->square;
    pbwc__lanes volume;
    size_t i;
    pbwc__load(mesh, weighted, from, last, &geometry);
    volume = pbwc__find_centre(&geometry, weighted);
    memcpy(x, geometry.to[0], sizeof x);
    memcpy(det, &volume, sizeof det);
    memcpy(square, geometry.square, sizeof contribution->square);
    for (i = 0; i < PBWC__LANES && from + i <= last; i++) {
        const double most = square[0][i] > square[1][i] ? square[0][i] : square[1][i];
        const double largest = most > square[2][i] ? most : square[2][i];
        const double *a = mesh->points + 3 * (size_t)mesh->simplices[4 * (from + i)];
        double centre[3];
        unsigned good = PBWC__GOOD;
        centre[0] = x[0][i];
        centre[1] = x[1][i];
        centre[2] = x[2][i];
        if (!pbwc__is_thick3(det[i], largest)) {
            good = pbwc__centre_of(mesh, 3, (pbw_index)(from + i), centre) ? PBWC__GOOD : 0;
            x[0][i] = centre[0];
            x[1][i] = centre[1];
            x[2][i] = centre[2];
        }
        good = largest > 1e-60 && largest < 1e60 ? good : 0;         /* else products may be out of range */
        contribution->flags[i] = good != 0 && pbwc__inside(job, 3, a, centre) ? good | PBWC__INSIDE : good;
    }
    memcpy(geometry.to[0], x, sizeof x);
    pbwc__sum_corners(&geometry, weighted);
    memcpy(contribution->sum, geometry.sum, sizeof contribution->sum);
    memcpy(contribution->given, geometry.given, sizeof contribution->given);
}

static void pbwc__contribute_plain(const pbwc__job *job, size_t from, size_t last, pbwc__contribution *contribution)
{
    pbwc__contribute(job, 0, from, last, contribution);
}

static void pbwc__contribute_weighted(const pbwc__job *job, size_t from, size_t last,
                                      pbwc__contribution *contribution)
{
    pbwc__contribute(job, 1, from, last, contribution);
}

/* Sets the flags of a simplex's corners. */
PBW_INLINE void pbwc__classify(const pbwc__job *job, size_t simplex, size_t from, size_t to, unsigned centre,
                               unsigned flags[4])
{
    const pbw_index *next = job->mesh->neighbors + 4 * simplex;
    size_t i, k;
    flags[0] = (centre & (job->bounded ? PBWC__INSIDE : PBWC__GOOD)) == 0 ? PBWC__LEFT : 0;
    flags[1] = flags[2] = flags[3] = flags[0];
    for (i = 0; i < 4; i++) {
        for (k = 0; k < 4 && next[i] - from >= to - from; k++) {
            flags[k] |= k == i ? 0 : next[i] == PBW_NONE ? PBWC__LEFT : PBWC__SHARED;
        }
    }
}

/* Returns the sum of a vertex in this chunk; NULL if there is no memory. */
PBW_INLINE pbwc__total *pbwc__total_of(pbwc__adder *adder, pbw_index vertex)
{
    pbw_memory *memory = &adder->job->memory;
    const int fresh = (int)adder->totals.count, number = pbwc__number(memory, &adder->numbers, vertex, fresh);
    if (number == fresh) {
        pbwc__total total;
        memset(&total, 0, sizeof total);
        total.vertex = vertex;
        if (!PBW_PUSH(memory, adder->totals, total)) {
            return NULL;
        }
    }
    return number < 0 ? NULL : adder->totals.at + number;
}

/* Adds up the contributions of a chunk.  Returns 0 if there is no memory. */
static int pbwc__add_simplices(pbwc__adder *adder, size_t from, size_t to)
{
    const pbwc__job *job = adder->job;
    const pbw_mesh *mesh = job->mesh;
    pbwc__contribution contribution;
    unsigned flags[4];
    size_t s, lane, i, k;
    for (s = from; s < to; s += PBWC__LANES) {
        (mesh->weights != NULL ? pbwc__contribute_weighted : pbwc__contribute_plain)(job, s, to - 1, &contribution);
        for (lane = 0; lane < PBWC__LANES && s + lane < to; lane++) {
            pbwc__classify(job, s + lane, from, to, contribution.flags[lane], flags);
            for (i = 0; i < 6 && job->parts.at != NULL; i++) {
                job->parts.at[6 * (s + lane) + i] = contribution.given[i][lane]
                                                    / (2 * sqrt(contribution.square[i][lane]));
            }
            for (i = 0; i < 4; i++) {
                pbwc__total *total = pbwc__total_of(adder, mesh->simplices[4 * (s + lane) + i]);
                if (total == NULL) {
                    return 0;
                }
                for (k = 0; k < 4; k++) {
                    total->sum[k] += contribution.sum[i][k][lane];
                }
                total->flags |= flags[i];
            }
        }
    }
    return 1;
}

/* Ends the cells of a chunk that are complete; keeps the other sums. */
static pbw_status pbwc__add_chunk(void *arg, size_t from, size_t to)
{
    pbwc__job *job = (pbwc__job *)arg;
    pbwc__totals *kept = &job->ranges.at[from / PBWC__CHUNK].totals;
    pbwc__adder adder;
    size_t i;
    int good;
    memset(&adder, 0, sizeof adder);
    adder.job = job;
    good = pbwc__map_grow(&job->memory, &adder.numbers) && pbwc__add_simplices(&adder, from, to);
    for (i = 0; good && i < adder.totals.count; i++) {
        const pbwc__total *total = adder.totals.at + i;
        if (total->vertex < job->count && total->flags == 0) {
            pbwc__set_cell(job, total->vertex, total->sum);
        } else if (total->vertex < job->count) {
            good = PBW_PUSH(&job->memory, *kept, *total);
        }
    }
    PBW_RELEASE(&job->memory, adder.numbers.slots);
    PBW_RELEASE(&job->memory, adder.totals);
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* ------------------------------------------------------------------------------------------------------
   >>facets       Facets read off stars.
   In: a star, the parts of simplices.  Out: the facets of its cell, with neighbours, areas and corners.
   In space the links are in the order in which the simplices of the star, ascending, have them, each simplex in the
   order of pbwc__other3.  The area of a facet is the sum of the parts that the simplices at its edge, ascending, have
   of it (>>totals): the same from both ends.
   In the plane they are counter-clockwise.
   ------------------------------------------------------------------------------------------------------ */
/* Appends a vector of 2 or 3 numbers to an array of doubles.  Returns its index there, PBW_NONE if there is no
   memory. */
static pbw_index pbwc__push_vector(pbwc__work *work, pbwc__doubles *array, const double *x)
{
    const size_t dim = (size_t)work->job->mesh->dim;
    size_t k;
    if (!PBW_RESERVE(work->memory, *array, dim)) {
        return PBW_NONE;
    }
    for (k = 0; k < dim; k++) {
        array->at[array->count++] = x[k];
    }
    return (pbw_index)(array->count / dim - 1);
}

/* Appends the direction a x c to a loop.  Its number counts the rays of the range.  Returns 0 if there is no memory.
   */
static int pbwc__push_ray(pbwc__work *work, const double *a, const double *c)
{
    double ray[3], unit[2][3], length[2] = { 0, 0 };
    pbw_index number;
    int k;
    for (k = 0; k < 3; k++) {                        /* first to length 1: products must not vanish */
        length[0] = fabs(a[k]) > length[0] ? fabs(a[k]) : length[0];
        length[1] = fabs(c[k]) > length[1] ? fabs(c[k]) : length[1];
    }
    for (k = 0; k < 3; k++) {
        unit[0][k] = a[k] / length[0];
        unit[1][k] = c[k] / length[1];
    }
    pbwc__cross(unit[0], unit[1], ray);
    length[0] = sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
    for (k = 0; k < 3 && length[0] > 0; k++) {
        ray[k] /= length[0];
    }
    number = pbwc__push_vector(work, &work->out->rays, ray);
    return number != PBW_NONE && PBW_PUSH(work->memory, work->out->loops, PBW_NONE - 1 - number);
}

/* Appends the centre of a part to a loop, unless merged centres would occur twice in a row. */
static int pbwc__push_centre(pbwc__work *work, const pbwc__part *part, size_t begin)
{
    const pbw_index *merged = work->job->merged.at;
    const pbw_index vertex = merged != NULL ? merged[part->simplex] : part->simplex;
    pbwc__indices *loops = &work->out->loops;
    if (merged != NULL && loops->count > begin && loops->at[loops->count - 1] == vertex) {
        return 1;
    }
    return PBW_PUSH(work->memory, *loops, vertex);
}

/* From the site to a vertex. */
static void pbwc__to_vertex(const pbwc__work *work, pbw_index vertex, double *d)
{
    const double *x = work->job->mesh->points;
    int k;
    for (k = 0; k < 3; k++) {
        d[k] = x[3 * (size_t)vertex + (size_t)k] - x[3 * (size_t)work->site + (size_t)k];
    }
}

/* Appends the loop of a link's facet in space, with two rays if it is open.  Returns 0 if there is no memory. */
static int pbwc__loop3(pbwc__work *work, const pbwc__link *link)
{
    const pbw_index *merged = work->job->merged.at, *ring = work->rings.at + link->begin;
    pbwc__indices *loops = &work->out->loops;
    const size_t begin = loops->count;
    pbw_index *out;
    size_t i, count = 0;
    if (!PBW_RESERVE(work->memory, *loops, link->count)) {
        return 0;
    }
    out = loops->at + begin;
    for (i = 0; merged == NULL && i < link->count; i++) {
        out[count++] = ring[i];
    }
    for (i = 0; merged != NULL && i < link->count; i++) {        /* no corner twice in a row */
        out[count] = merged[ring[i]];
        count += count == 0 || out[count] != out[count - 1];
    }
    loops->count += count;
    if (link->open) {                                /* outward normals of the hull facets at both ends */
        double low[3], high[3];
        pbwc__to_vertex(work, link->ends[0], low);
        pbwc__to_vertex(work, link->ends[1], high);
        return pbwc__push_ray(work, link->d, high) && pbwc__push_ray(work, low, link->d);
    }
    if (count > 1 && out[0] == out[count - 1]) {
        loops->count--;                              /* merged across the start */
    }
    return loops->count > begin;
}

/* Returns whether the facet of a link has an area in the true diagram.  In space a closed one has none if its corners
   are at one or two places, an open one if it is a ray: all corners at one place, the hull facets at both ends in one
   plane. */
static int pbwc__is_facet(const pbwc__work *work, const pbwc__link *link)
{
    const pbw_index *merged = work->job->merged.at;
    const pbwc__part *part = work->parts.at;
    const pbw_mesh *mesh = work->job->mesh;
    const pbw_index *ring;
    size_t i, differ = 0;
    if (merged == NULL) {
        return 1;
    }
    if (mesh->dim == 2) {
        return link->open || merged[part[link->from].simplex] != merged[part[link->to].simplex];
    }
    ring = work->rings.at + link->begin;
    for (i = 1; i < link->count; i++) {
        differ += merged[ring[i]] != merged[ring[i - 1]];
    }
    if (link->open) {
        return differ > 0
               || pbw_orient3(mesh->points + 3 * (size_t)work->site, mesh->points + 3 * (size_t)link->vertex,
                              mesh->points + 3 * (size_t)link->ends[1],
                              mesh->points + 3 * (size_t)link->ends[0]) != 0;
    }
    return differ + (merged[ring[0]] != merged[ring[i - 1]]) > 2;
}

static int pbwc__facet_done(pbwc__work *work, pbw_index neighbor, double area, size_t loop_begin)
{
    pbwc__range *out = work->out;
    if (!PBW_RESERVE(work->memory, out->areas, 1) || !PBW_PUSH(work->memory, out->neighbors, neighbor)
        || ((work->job->what & PBW_CELLS_SHAPES) != 0
            && !PBW_PUSH(work->memory, out->loop_counts, (pbw_index)(out->loops.count - loop_begin)))) {
        return 0;
    }
    out->areas.at[out->areas.count++] = area;
    return 1;
}

/* In space. */
static int pbwc__link_facet3(pbwc__work *work, const pbwc__link *link)
{
    const size_t begin = work->out->loops.count;
    return ((work->job->what & PBW_CELLS_SHAPES) == 0 || pbwc__loop3(work, link))
           && pbwc__facet_done(work, link->vertex, link->open ? HUGE_VAL : link->area, begin);
}

/* In the plane: the edge between the centres of two parts, of which one may be -1: then it is a ray. */
static int pbwc__link_facet2(pbwc__work *work, const pbwc__link *link)
{
    static const double up[3] = { 0, 0, 1 }, down[3] = { 0, 0, -1 };
    const pbwc__part *from = work->parts.at + (link->from < 0 ? 0 : link->from);
    const pbwc__part *to = work->parts.at + (link->to < 0 ? 0 : link->to);
    const size_t begin = work->out->loops.count;
    double length = HUGE_VAL;
    if (!link->open) {
        const double x = to->centre[0] - from->centre[0], y = to->centre[1] - from->centre[1];
        length = (link->d[0] * y - link->d[1] * x) / sqrt(link->d[0] * link->d[0] + link->d[1] * link->d[1]);
    }
    if ((work->job->what & PBW_CELLS_SHAPES) != 0
        && !((link->from >= 0 ? pbwc__push_centre(work, from, begin) : pbwc__push_ray(work, link->d, up))
             && (link->to >= 0 ? pbwc__push_centre(work, to, begin) : pbwc__push_ray(work, link->d, down)))) {
        return 0;
    }
    return pbwc__facet_done(work, link->vertex, length, begin);
}

/* Sorts in place (Shell). */
static void pbwc__sort_star(pbw_index *star, size_t count)
{
    size_t gap = 1, i, j;
    while (gap < count / 9) {
        gap = 3 * gap + 1;
    }
    for (; gap > 0; gap /= 3) {
        for (i = gap; i < count; i++) {
            const pbw_index s = star[i];
            for (j = i; j >= gap && star[j - gap] > s; j -= gap) {
                star[j] = star[j - gap];
            }
            star[j] = s;
        }
    }
}

/* The order of the links, in space, and the areas towards them; makes links that are missing.  Returns 0 if there is
   no memory. */
static int pbwc__order_links(pbwc__work *work)
{
    static const unsigned char edge[4][4] = { { 0, 0, 1, 2 }, { 0, 0, 3, 4 }, { 1, 3, 0, 5 }, { 2, 4, 5, 0 } };
    const pbwc__job *job = work->job;
    size_t s, i, k;
    work->order.count = 0;
    pbwc__sort_star(work->star.at, work->star.count);
    for (s = 0; s < work->star.count; s++) {
        const pbw_index simplex = work->star.at[s], *corner = job->mesh->simplices + 4 * (size_t)simplex;
        for (i = 0; corner[i] != work->site; i++) {
        }
        for (k = 0; k < 3; k++) {
            const size_t j = pbwc__other3[i][k];
            const int fresh = (int)work->links.count;
            const int number = pbwc__number(work->memory, &work->numbers, corner[j], fresh);
            pbwc__link *link = number == fresh ? pbwc__add_link(work, 3, corner[j]) : work->links.at + number;
            if (number < 0 || link == NULL
                || (!link->listed && !PBW_PUSH(work->memory, work->order, (pbw_index)number))) {
                return 0;
            }
            link->listed = 1;
            link->area += job->parts.at[6 * (size_t)simplex + edge[i][j]];
        }
    }
    return 1;
}

/* The facets of the star.  Returns 0 if there is no memory. */
static int pbwc__star_facets(pbwc__work *work)
{
    const int space = work->job->mesh->dim == 3;
    size_t u;
    if (space && !pbwc__order_links(work)) {
        return 0;
    }
    for (u = 0; u < work->links.count; u++) {
        const pbwc__link *link = work->links.at + (space ? work->order.at[u] : u);
        if (pbwc__is_facet(work, link)
            && !(space ? pbwc__link_facet3(work, link) : pbwc__link_facet2(work, link))) {
            return 0;
        }
    }
    return 1;
}

/* ------------------------------------------------------------------------------------------------------
   >>cuts         Cells cut from the domain: those with corners outside the domain, or sites on the hull.
   In: a star, the domain.  Out: the polytope of the cell, and its facets.
   ------------------------------------------------------------------------------------------------------ */
/* Makes the domain's polytope relative to the site, cut by the bisectors of all links.  Returns 0 if there is no
   memory. */
static int pbwc__cut_cell(pbwc__work *work, pbw_index v)
{
    const pbwc__job *job = work->job;
    const size_t dim = (size_t)job->mesh->dim, corners = job->domain.x.count, facets = job->domain.start.count;
    const double *site = job->mesh->points + v * dim;
    const unsigned axes = job->period != NULL ? job->period->axes : 0;
    pbwc__poly *poly = &work->cutter.poly;
    size_t i, k;
    int u;
    pbwc__poly_clear(poly);
    poly->x.count = 0;
    if (!PBW_RESERVE(work->memory, poly->x, corners)) {
        return 0;
    }
    for (i = 0; i < corners; i++) {
        for (k = 0; k < 3; k++) {
            poly->x.at[i][k] = job->domain.x.at[i][k] - (k >= dim || (axes >> k & 1) != 0 ? 0 : site[k]);
        }
    }
    poly->x.count = corners;
    for (i = 0; i < facets; i++) {
        if (!pbwc__begin_facet(work->memory, poly, job->domain.name.at[i])) {
            return 0;
        }
        for (k = job->domain.start.at[i]; k < pbwc__loop_end(&job->domain, i); k++) {
            if (!PBW_PUSH(work->memory, poly->loop, job->domain.loop.at[k])) {
                return 0;
            }
        }
    }
    for (u = 0; u < (int)work->links.count; u++) {
        const pbwc__link *link = work->links.at + u;
        double plane[4] = { 0, 0, 0, 0 }, square = 0;
        for (k = 0; k < dim; k++) {
            plane[k] = link->d[k];
            square += link->d[k] * link->d[k];
        }
        plane[dim] = link->foot * square;
        if (!pbwc__cut(work->memory, &work->cutter, (int)dim, plane, (pbw_index)u)) {
            return 0;
        }
    }
    return 1;
}

/* Appends a corner of a facet of the star's polytope, made at its first use.  Returns 0 if there is no memory. */
static int pbwc__star_corner(pbwc__work *work, pbw_index simplex)
{
    const size_t dim = (size_t)work->job->mesh->dim;
    const double *site = work->job->mesh->points + work->site * dim;
    pbwc__poly *poly = &work->cutter.poly;
    const int fresh = (int)poly->x.count, number = pbwc__number(work->memory, &work->numbers, simplex, fresh);
    if (number == fresh) {
        if (!PBW_RESERVE(work->memory, poly->x, 1)) {
            return 0;
        }
        poly->x.at[fresh][2] = 0;
        (void)pbwc__from_site(work->job, work->centres.at, dim, site, simplex, poly->x.at[fresh]);
        poly->x.count++;
    }
    return number >= 0 && PBW_PUSH(work->memory, poly->loop, (pbw_index)number);
}

/* The polytope of a closed star with good centres. */
static int pbwc__star_poly(pbwc__work *work)
{
    const int plane = work->job->mesh->dim == 2;
    pbwc__poly *poly = &work->cutter.poly;
    size_t u, i;
    pbwc__poly_clear(poly);
    poly->x.count = 0;
    pbwc__map_clear(&work->numbers);
    for (u = 0; u < work->links.count; u++) {
        const pbwc__link *link = work->links.at + u;
        if (!pbwc__begin_facet(work->memory, poly, (pbw_index)u)) {
            return 0;
        }
        for (i = 0; i < (plane ? 1 : link->count); i++) {
            if (!pbwc__star_corner(work, plane ? work->parts.at[link->from].simplex
                                               : work->rings.at[link->begin + i])) {
                return 0;
            }
        }
    }
    return 1;
}

/* Cuts the star's polytope by the walls of the domain. */
static int pbwc__cut_star(pbwc__work *work, pbw_index v)
{
    const pbwc__job *job = work->job;
    const size_t dim = (size_t)job->mesh->dim;
    const double *site = job->mesh->points + v * dim;
    double plane[4];
    size_t i, k;
    for (i = 0; i < 2 * dim; i++) {
        const double wall = i % 2 != 0 ? job->high[i / 2] - site[i / 2] : site[i / 2] - job->low[i / 2];
        memset(plane, 0, sizeof plane);
        plane[i / 2] = i % 2 != 0 ? 1 : -1;
        plane[dim] = wall;
        if (wall < HUGE_VAL
            && !pbwc__cut(work->memory, &work->cutter, (int)dim, plane, (pbw_index)(PBW_NONE - 1 - i))) {
            return 0;
        }
    }
    for (i = 0; i < job->plane_count; i++) {
        const double *from = job->planes + i * (dim + 1);
        plane[dim] = from[dim];
        for (k = 0; k < dim; k++) {
            plane[k] = from[k];
            plane[dim] -= from[k] * site[k];
        }
        if (!pbwc__cut(work->memory, &work->cutter, (int)dim, plane, (pbw_index)(PBW_NONE - 1 - 2 * dim - i))) {
            return 0;
        }
    }
    return 1;
}

/* Twice the area vector of a facet, or an edge's vector; adds its cone over the site to sum. */
static double pbwc__sum_facet(const pbwc__poly *poly, size_t facet, int dim, double *sum)
{
    const pbw_index *loop = poly->loop.at + poly->start.at[facet];
    const size_t count = pbwc__loop_end(poly, facet) - poly->start.at[facet];
    double area[3] = { 0, 0, 0 }, across[3], w;
    size_t i;
    int k;
    if (dim == 2) {
        const double *a = poly->x.at[loop[0]];
        const double *b = poly->x.at[poly->loop.at[facet + 1 < poly->loop.count ? facet + 1 : 0]];
        w = a[0] * b[1] - a[1] * b[0];
        sum[3] += w;
        sum[0] += w * (a[0] + b[0]);
        sum[1] += w * (a[1] + b[1]);
        return sqrt((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]));
    }
    for (i = 1; i + 1 < count; i++) {
        const double *a = poly->x.at[loop[0]], *b = poly->x.at[loop[i]], *c = poly->x.at[loop[i + 1]];
        double p[3], q[3];
        pbwc__cross(b, c, across);
        w = a[0] * across[0] + a[1] * across[1] + a[2] * across[2];
        sum[3] += w;
        for (k = 0; k < 3; k++) {
            sum[k] += w * (a[k] + b[k] + c[k]);
            p[k] = b[k] - a[k];
            q[k] = c[k] - a[k];
        }
        pbwc__cross(p, q, across);
        for (k = 0; k < 3; k++) {
            area[k] += across[k];
        }
    }
    return 0.5 * sqrt(area[0] * area[0] + area[1] * area[1] + area[2] * area[2]);
}

/* The corners of a facet as the range's own vertices: each corner of the cell once. */
static int pbwc__cut_loop_out(pbwc__work *work, pbw_index v, size_t facet, pbw_index *number)
{
    const pbwc__poly *poly = &work->cutter.poly;
    const size_t dim = (size_t)work->job->mesh->dim, simplices = work->job->mesh->simplex_count;
    const double *site = work->job->mesh->points + v * dim;
    size_t i, k, begin = poly->start.at[facet], end = pbwc__loop_end(poly, facet) + (dim == 2);
    for (i = begin; i < end; i++) {
        const pbw_index corner = poly->loop.at[i < poly->loop.count ? i : 0];
        if (number[corner] == PBW_NONE) {
            double x[3];
            for (k = 0; k < dim; k++) {
                x[k] = site[k] + poly->x.at[corner][k];
            }
            number[corner] = pbwc__push_vector(work, &work->out->vertices, x);
            if (number[corner] == PBW_NONE) {
                return 0;
            }
        }
        if (!PBW_PUSH(work->memory, work->out->loops, (pbw_index)simplices + number[corner])) {
            return 0;
        }
    }
    return 1;
}

/* Facets of a cut cell are named by their link or wall. */
static pbw_index pbwc__name_of(const pbwc__work *work, pbw_index name)
{
    return name < work->links.count ? work->links.at[name].vertex : name;
}

/* Adds the facets of the cut cell.  If rounding has bent the surface, a plane may have several facets in a row: one
   facet gets the sum of their areas and the loop of the largest. */
static int pbwc__cut_facets(pbwc__work *work, pbw_index v)
{
    const pbwc__poly *poly = &work->cutter.poly;
    pbwc__indices *numbers = &work->cutter.cap;      /* of corners; the cap is done */
    const pbw_index *name = poly->name.at;
    const int dim = work->job->mesh->dim;
    double sum[4] = { 0, 0, 0, 0 };
    size_t i, next;
    numbers->count = 0;
    if (!PBW_RESERVE(work->memory, *numbers, poly->x.count)) {
        return 0;
    }
    for (i = 0; i < poly->x.count; i++) {
        numbers->at[i] = PBW_NONE;
    }
    for (i = 0; i < poly->start.count; i = next) {
        const size_t begin = work->out->loops.count;
        double area = pbwc__sum_facet(poly, i, dim, sum), largest = area;
        size_t best = i;
        for (next = i + 1; dim == 3 && next < poly->start.count && name[next] == name[i]; next++) {
            const double more = pbwc__sum_facet(poly, next, dim, sum);
            best = more > largest ? next : best;
            largest = more > largest ? more : largest;
            area += more;
        }
        if (((work->job->what & PBW_CELLS_SHAPES) != 0
             && !pbwc__cut_loop_out(work, v, best, numbers->at))
            || !pbwc__facet_done(work, pbwc__name_of(work, name[i]), area, begin)) {
            return 0;
        }
    }
    return 1;
}

/* ------------------------------------------------------------------------------------------------------
   >>true         Cut cells of the true diagram: from the box around the domain, by its planes and the bisectors, with
   exact signs.
   A corner is known by three planes a b c of facets that meet in it; row n c is the plane n.x <= c.  With
       X = c_a b x c + c_b c x a + c_c a x b,  D = a.(b x c)    it is at X / D,
   and n.X - c D has the sign of D if it is beyond a plane.  In the plane of the drawing, z = 0 is the third plane.
   Errors to first order, each relative to the terms: rows 1 eps for n and 6 for c, so 8 for D, 13 for X, and 18 in
   all.
   Rows are scaled by powers of two so that n is of size 1, and lengths so that the domain is.
   Holds: a facet has an area, an edge a length, and no corner occurs twice, but for coordinates, which are rounded.
   ------------------------------------------------------------------------------------------------------ */
#define PBWC__EPS 1.2e-16                  /* above 2^-53 */

typedef struct pbwc__row { double n[3], c, size; } pbwc__row;        /* size: of the terms of c */

/* The wall of a facet's name: below 2 dim of the box, then planes. */
static size_t pbwc__wall_of(pbw_index name)
{
    return (size_t)(PBW_NONE - 1 - name);
}

/* The site, from which coordinates of the domain count; along periodic axes these do already. */
static double pbwc__origin(const pbwc__work *work, size_t axis)
{
    const pbwc__job *job = work->job;
    return job->period != NULL && (job->period->axes >> axis & 1) != 0 ? 0
         : job->mesh->points[work->site * (size_t)job->mesh->dim + axis];
}

static double pbwc__weight(const pbw_mesh *mesh, pbw_index v)
{
    return mesh->weights != NULL ? mesh->weights[v] : 0;
}

/* The plane of a facet; PBW_NONE: z = 0. */
static void pbwc__row_of(const pbwc__work *work, pbw_index name, pbwc__row *row)
{
    const pbwc__job *job = work->job;
    const size_t dim = (size_t)job->mesh->dim, wall = pbwc__wall_of(name);
    const int unit = -job->exponent;
    double largest = 0;
    int exponent;
    size_t k;
    memset(row, 0, sizeof *row);
    if (name == PBW_NONE) {
        row->n[2] = 1;
    } else if (name < work->links.count || wall >= 2 * dim) {
        const int bisector = name < work->links.count;
        const pbwc__link *link = bisector ? work->links.at + name : NULL;
        const double *plane = bisector ? NULL : job->planes + (wall - 2 * dim) * (dim + 1), *w = job->mesh->weights;
        const double *n = bisector ? link->d : plane;
        for (k = 0; k < dim; k++) {
            largest = fabs(n[k]) > largest ? fabs(n[k]) : largest;
        }
        (void)frexp(largest, &exponent);
        for (k = 0; k < dim; k++) {
            const double scaled = ldexp(n[k], -exponent);
            const double more = scaled * (bisector ? ldexp(n[k], unit) : -ldexp(pbwc__origin(work, k), unit));
            row->n[k] = bisector ? 2 * scaled : scaled;
            row->c += more;
            row->size += fabs(more);
        }
        if (!bisector) {
            row->c += ldexp(plane[dim], unit - exponent);
            row->size += fabs(ldexp(plane[dim], unit - exponent));
        } else if (w != NULL) {
            const double a = w[work->site], b = w[link->vertex];
            row->c += ldexp(a - b, unit - exponent);
            row->size += ldexp(fabs(a) + fabs(b), unit - exponent);
        }
    } else {
        const double at = wall % 2 != 0 ? job->to[wall / 2] : job->from[wall / 2], o = pbwc__origin(work, wall / 2);
        row->n[wall / 2] = wall % 2 != 0 ? 1 : -1;
        row->c = row->n[wall / 2] * ldexp(at - o, unit);
        row->size = ldexp(fabs(at) + fabs(o), unit);
    }
    row->size = row->size < 1e100 ? row->size : HUGE_VAL;            /* else products may be out of range */
}

/* The same, exactly, but for the scales. */
static void pbwc__row_exactly(const pbwc__work *work, pbw_index name, pbwc__exact row[4])
{
    const pbwc__job *job = work->job;
    const pbw_mesh *mesh = job->mesh;
    const size_t dim = (size_t)mesh->dim, wall = pbwc__wall_of(name);
    pbwc__exact o;
    size_t k;
    for (k = 0; k < 4; k++) {
        pbwc__exact_of(name == PBW_NONE && k == 2, row + k);
    }
    if (name < work->links.count) {
        const pbw_index vertex = work->links.at[name].vertex;
        pbwc__exact_minus(pbwc__weight(mesh, work->site), pbwc__weight(mesh, vertex), row + 3);
        for (k = 0; k < dim; k++) {
            pbwc__exact_minus(mesh->points[vertex * dim + k], mesh->points[work->site * dim + k], row + k);
            pbwc__exact_add_product(row + 3, row + k, row + k, 1);
            o = row[k];
            pbwc__exact_add(row + k, &o, 1);
        }
    } else if (name != PBW_NONE && wall < 2 * dim) {
        const double origin = pbwc__origin(work, wall / 2);
        pbwc__exact_of(wall % 2 != 0 ? 1 : -1, row + wall / 2);
        pbwc__exact_minus(wall % 2 != 0 ? job->to[wall / 2] : origin,
                          wall % 2 != 0 ? origin : job->from[wall / 2], row + 3);
    } else if (name != PBW_NONE) {
        const double *plane = job->planes + (wall - 2 * dim) * (dim + 1);
        pbwc__exact_of(plane[dim], row + 3);
        for (k = 0; k < dim; k++) {
            pbwc__exact_of(plane[k], row + k);
            pbwc__exact_of(pbwc__origin(work, k), &o);
            pbwc__exact_add_product(row + 3, row + k, &o, -1);
        }
    }
}

/* Computes the place of a corner. */
static void pbwc__find_spot(const pbwc__work *work, pbwc__spot *spot)
{
    pbwc__row row[3];
    int i, k;
    memset(spot->x, 0, sizeof spot->x);
    memset(spot->x_size, 0, sizeof spot->x_size);
    spot->det = spot->det_size = 0;
    spot->known = 1;
    for (i = 0; i < 3; i++) {
        pbwc__row_of(work, spot->plane[i], row + i);
    }
    for (i = 0; i < 3; i++) {
        const double *p = row[(i + 1) % 3].n, *q = row[(i + 2) % 3].n;
        for (k = 0; k < 3; k++) {
            const double s = p[(k + 1) % 3] * q[(k + 2) % 3], t = p[(k + 2) % 3] * q[(k + 1) % 3];
            spot->x[k] += row[i].c * (s - t);
            spot->x_size[k] += row[i].size * (fabs(s) + fabs(t));
            spot->det += i == 0 ? row[0].n[k] * (s - t) : 0;
            spot->det_size += i == 0 ? fabs(row[0].n[k]) * (fabs(s) + fabs(t)) : 0;
        }
    }
}

/* Returns 1 if a corner is beyond a plane, 0 on it, else -1: minus the signs of D and of the determinant of the four
   rows, by pairs of rows (Laplace). */
static int pbwc__beyond_exactly(const pbwc__work *work, const pbwc__spot *spot, pbw_index name)
{
    static const int pair[6][2] = { { 0, 1 }, { 0, 2 }, { 0, 3 }, { 1, 2 }, { 1, 3 }, { 2, 3 } };
    static const int sign[6] = { 1, -1, 1, 1, -1, 1 };
    pbwc__exact row[4][4], first, second, all, det;
    int i;
    for (i = 0; i < 4; i++) {
        pbwc__row_exactly(work, i < 3 ? spot->plane[i] : name, row[i]);
    }
    pbwc__exact_of(0, &all);
    pbwc__exact_of(0, &det);
    for (i = 0; i < 6; i++) {
        const int a = pair[i][0], b = pair[i][1], c = pair[5 - i][0], d = pair[5 - i][1];
        pbwc__exact_minor(&row[0][a], &row[0][b], &row[1][a], &row[1][b], &first);
        pbwc__exact_minor(&row[2][c], &row[2][d], &row[3][c], &row[3][d], &second);
        pbwc__exact_add_product(&all, &first, &second, sign[i]);
        if (b < 3) {
            pbwc__exact_add_product(&det, &first, &row[2][3 - a - b], sign[i]);
        }
    }
    return -all.sign * det.sign;
}

static int pbwc__beyond(const pbwc__work *work, pbwc__spot *spot, const pbwc__row *row, pbw_index name)
{
    double value, size;
    int k;
    if (!spot->known) {
        pbwc__find_spot(work, spot);
    }
    value = -row->c * spot->det;
    size = row->size * spot->det_size;
    for (k = 0; k < 3; k++) {
        value += row->n[k] * spot->x[k];
        size += fabs(row->n[k]) * spot->x_size[k];
    }
    if (size > 1e-100 && spot->det_size > 1e-100 && fabs(value) > 24 * PBWC__EPS * size
        && fabs(spot->det) > 12 * PBWC__EPS * spot->det_size) {
        return (value > 0) == (spot->det > 0) ? 1 : -1;
    }
    return pbwc__beyond_exactly(work, spot, name);
}

/* Keeps the part that is not beyond the plane of a name.  Returns 0 if there is no memory. */
static int pbwc__cut_by(pbwc__work *work, pbw_index name)
{
    pbwc__cutter *cutter = &work->cutter;
    const pbwc__poly *poly = &cutter->poly;
    const size_t count = poly->x.count;
    double *side;
    size_t i, outside = 0;
    pbwc__row row;
    int k;
    cutter->side.count = 0;
    if (!PBW_RESERVE(work->memory, cutter->side, count)) {
        return 0;
    }
    side = cutter->side.at;
    pbwc__row_of(work, name, &row);
    for (i = 0; i < count; i++) {
        side[i] = HUGE_VAL;                          /* not yet known */
    }
    for (i = 0; i < poly->loop.count; i++) {
        const pbw_index corner = poly->loop.at[i];
        const double *x = poly->x.at[corner];
        double about = -ldexp(row.c, work->job->exponent);
        int sign;
        if (side[corner] < HUGE_VAL) {
            continue;
        }
        sign = pbwc__beyond(work, cutter->spots.at + corner, &row, name);
        for (k = 0; k < 3; k++) {
            about += row.n[k] * x[k];
        }
        side[corner] = sign * about > PBWC__TINY && fabs(about) < HUGE_VAL ? about : sign * PBWC__TINY;
        outside += sign > 0;
    }
    return outside == 0 || pbwc__cut_by_sides(work->memory, cutter, work->job->mesh->dim, name);
}

/* Makes the cell of the star within the domain, with the combinatorics of the true diagram.  Returns 0 if there is no
   memory. */
static int pbwc__cut_exactly(pbwc__work *work)
{
    const pbwc__job *job = work->job;
    const size_t dim = (size_t)job->mesh->dim;
    pbwc__cutter *cutter = &work->cutter;
    double low[3] = { 0, 0, 0 }, high[3] = { 0, 0, 0 };
    size_t i, k;
    for (k = 0; k < dim; k++) {
        low[k] = job->from[k] - pbwc__origin(work, k);
        high[k] = job->to[k] - pbwc__origin(work, k);
    }
    if (!pbwc__poly_box(work->memory, &cutter->poly, (int)dim, low, high)) {
        return 0;
    }
    cutter->spots.count = 0;
    for (i = 0; i < cutter->poly.x.count; i++) {
        pbw_index wall[3] = { PBW_NONE, PBW_NONE, PBW_NONE };
        for (k = 0; k < dim; k++) {
            wall[k] = (pbw_index)(PBW_NONE - 1 - 2 * k - (i >> k & 1));
        }
        if (!pbwc__add_spot(work->memory, cutter, wall[0], wall[1], wall[2])) {
            return 0;
        }
    }
    for (i = 0; i < job->plane_count; i++) {
        if (!pbwc__cut_by(work, (pbw_index)(PBW_NONE - 1 - 2 * dim - i))) {
            return 0;
        }
    }
    for (i = 0; i < work->links.count && cutter->poly.start.count > 0; i++) {
        if (pbwc__is_facet(work, work->links.at + i) && !pbwc__cut_by(work, (pbw_index)i)) {
            return 0;
        }
    }
    return 1;
}

/* ------------------------------------------------------------------------------------------------------
   >>signs        Exact signs for polygons in the plane.
   Each is first tried in doubles, against a bound of its rounding errors.
   In: coordinates that are 0 or from PBWC__LEAST to PBWC__MOST in size, weights likewise with the squares of those.
   Out: signs.
   Then no product of four overflows or underflows in doubles.
   ------------------------------------------------------------------------------------------------------ */
#define PBWC__LEAST 1e-57
#define PBWC__MOST  1e60

/* Returns the power distance of p from i minus that from j, (j - i).((p - i) + (p - j)) + w_j - w_i; *size: the sum
   of the absolute values of its terms.  The error is below 6 eps *size to first order: 1 for j - i, 2 for the second
   factor, and 3 for the product and the sums. */
static double pbwc__closer(const pbw_mesh *mesh, const double *p, pbw_index i, pbw_index j, double *size)
{
    const double *a = mesh->points + 2 * (size_t)i, *b = mesh->points + 2 * (size_t)j;
    const double wi = pbwc__weight(mesh, i), wj = pbwc__weight(mesh, j);
    double sum = wj - wi;
    int k;
    *size = fabs(wi) + fabs(wj);
    for (k = 0; k < 2; k++) {
        const double d = b[k] - a[k], s = p[k] - a[k], t = p[k] - b[k];
        sum += d * (s + t);
        *size += fabs(d) * (fabs(s) + fabs(t));
    }
    return sum;
}

/* Returns the sign of pbwc__closer: 1 if p is nearer to j, 0 on the line between the cells of i and j. */
static int pbwc__side(const pbw_mesh *mesh, const double *p, pbw_index i, pbw_index j)
{
    const double *a = mesh->points + 2 * (size_t)i, *b = mesh->points + 2 * (size_t)j;
    pbwc__exact sum, d, s;
    double size;
    const double about = pbwc__closer(mesh, p, i, j, &size);
    int k;
    if (fabs(about) > 8 * PBWC__EPS * size) {
        return about > 0 ? 1 : -1;
    }
    pbwc__exact_minus(pbwc__weight(mesh, j), pbwc__weight(mesh, i), &sum);
    for (k = 0; k < 2; k++) {
        pbwc__exact_minus(b[k], a[k], &d);
        pbwc__exact_minus(p[k], a[k], &s);
        pbwc__exact_add_product(&sum, &d, &s, 1);
        pbwc__exact_minus(p[k], b[k], &s);
        pbwc__exact_add_product(&sum, &d, &s, 1);
    }
    return sum.sign;
}

/* The centre of a triangle relative to its first corner is N / (2 D): *det: D; normal: N. */
static void pbwc__exact_centre(const pbw_mesh *mesh, pbw_index simplex, pbwc__exact *det, pbwc__exact normal[2])
{
    const pbw_index *corner = mesh->simplices + 3 * (size_t)simplex;
    const double *a = mesh->points + 2 * (size_t)corner[0];
    pbwc__exact d[2][2], height[2];
    int i, k;
    for (i = 0; i < 2; i++) {
        const double *b = mesh->points + 2 * (size_t)corner[i + 1];
        pbwc__exact_minus(pbwc__weight(mesh, corner[0]), pbwc__weight(mesh, corner[i + 1]), &height[i]);
        for (k = 0; k < 2; k++) {
            pbwc__exact_minus(b[k], a[k], &d[i][k]);
            pbwc__exact_add_product(&height[i], &d[i][k], &d[i][k], 1);
        }
    }
    pbwc__exact_minor(&d[0][0], &d[0][1], &d[1][0], &d[1][1], det);
    pbwc__exact_minor(&height[0], &height[1], &d[0][1], &d[1][1], &normal[0]);       /* h0 d1y - h1 d0y */
    pbwc__exact_minor(&height[1], &height[0], &d[1][0], &d[0][0], &normal[1]);       /* h1 d0x - h0 d1x */
}

/* The centre of a triangle so flat that pairs of doubles do not resolve it. */
static void pbwc__centre_of_flat(const pbw_mesh *mesh, pbw_index simplex, double *centre)
{
    pbwc__exact det, normal[2];
    pbwc__exact_centre(mesh, simplex, &det, normal);
    centre[0] = pbwc__exact_value(&normal[0]) / (2 * pbwc__exact_value(&det));
    centre[1] = pbwc__exact_value(&normal[1]) / (2 * pbwc__exact_value(&det));
}

/* pbwc__centre_side without the filter. */
static int pbwc__centre_side_exactly(const pbw_mesh *mesh, const double *p, const double *q, pbw_index simplex)
{
    const double *a = mesh->points + 2 * (size_t)mesh->simplices[3 * (size_t)simplex];
    pbwc__exact u[2], r[2], det, turn, normal[2], sum;
    int k;
    for (k = 0; k < 2; k++) {
        pbwc__exact_minus(q[k], p[k], &u[k]);
        pbwc__exact_minus(a[k], p[k], &r[k]);
    }
    pbwc__exact_centre(mesh, simplex, &det, normal);
    pbwc__exact_minor(&u[0], &u[1], &r[0], &r[1], &turn);
    pbwc__exact_minor(&u[0], &u[1], &normal[0], &normal[1], &sum);
    pbwc__exact_add_product(&sum, &det, &turn, 1);
    pbwc__exact_add_product(&sum, &det, &turn, 1);
    return sum.sign;
}

/* Returns on which side of the line from p to q the centre of a simplex is: 1 left, -1 right, 0 on it.  With u = q -
   p, r = a - p and centre = a + N / (2 D) as above, this is the sign of 2 D (u x r) + u x N.  Errors to first order,
   each relative to its terms: 4 eps for D and u x r, 5 for the heights, 8 for N, so 10 and with the sums 12 in all.
   */
static int pbwc__centre_side(const pbw_mesh *mesh, const double *p, const double *q, pbw_index simplex)
{
    const pbw_index *corner = mesh->simplices + 3 * (size_t)simplex;
    const double *a = mesh->points + 2 * (size_t)corner[0];
    const double u[2] = { q[0] - p[0], q[1] - p[1] }, r[2] = { a[0] - p[0], a[1] - p[1] };
    double d[2][2], h[2], size[2], sum, bound;
    int i, k;
    for (i = 0; i < 2; i++) {
        const double *b = mesh->points + 2 * (size_t)corner[i + 1];
        const double w = pbwc__weight(mesh, corner[0]), x = pbwc__weight(mesh, corner[i + 1]);
        for (k = 0; k < 2; k++) {
            d[i][k] = b[k] - a[k];
        }
        h[i] = d[i][0] * d[i][0] + d[i][1] * d[i][1];
        size[i] = h[i] + fabs(w) + fabs(x);
        h[i] += w - x;
    }
    sum = 2 * (d[0][0] * d[1][1] - d[0][1] * d[1][0]) * (u[0] * r[1] - u[1] * r[0])
          + (u[0] * (h[1] * d[0][0] - h[0] * d[1][0]) - u[1] * (h[0] * d[1][1] - h[1] * d[0][1]));
    bound = 2 * (fabs(d[0][0] * d[1][1]) + fabs(d[0][1] * d[1][0])) * (fabs(u[0] * r[1]) + fabs(u[1] * r[0]))
            + fabs(u[0]) * (size[1] * fabs(d[0][0]) + size[0] * fabs(d[1][0]))
            + fabs(u[1]) * (size[0] * fabs(d[1][1]) + size[1] * fabs(d[0][1]));
    if (fabs(sum) > 16 * PBWC__EPS * bound) {
        return sum > 0 ? 1 : -1;
    }
    return pbwc__centre_side_exactly(mesh, p, q, simplex);
}

/* ------------------------------------------------------------------------------------------------------
   >>rings        The boundary of what rings enclose, by a plane sweep over the corners in order of x, then y (Shamos,
   Hoey 1976).
   Edges are cut at all corners on them.  Pieces of edges that lie on each other cancel in pairs, so neighbours that
   share edges become one, and spikes and rings without area vanish.  Two edges that cross elsewhere are an error.
   Bars are active pieces, from a corner on the left to one further right, each of one or more edges; they are sorted
   from below in a skip list (Pugh 1990).  The pieces of bars with an odd number of edges are the boundary.
   At a corner, each sector of the inside joins the piece that comes in on its one side with the one that goes out on
   its other side, so what touches itself in a corner gets loops that do not cross if moved inward.
   In: rings.  Out: pieces, each with the inside on its left and the one that follows.
   Holds: corners of one place have one number; numbers ascend from left to right.
   ------------------------------------------------------------------------------------------------------ */
#define PBWC__LEVELS 16                    /* of the skip list */

typedef struct pbwc__bar {
    pbw_index from, to, edges, piece;      /* corners; a list of edges; PBW_NONE: it is no boundary */
    int inside, height;                    /* inside: above it */
    pbw_index next[PBWC__LEVELS];
} pbwc__bar;

typedef struct pbwc__piece {
    pbw_index from, to, edge, then;        /* from left to right; then: the piece that follows */
    int up, alone;                         /* is the inside above?  alone: no other loop is at its end */
    int done;
} pbwc__piece;

typedef struct pbwc__way {                 /* of edges from a corner to the right */
    const double *from, *to;
    pbw_index end, edges, last;            /* the furthest corner; a list of edges */
    size_t count;
} pbwc__way;

typedef struct pbwc__place { const double *x; pbw_index corner; } pbwc__place;

typedef struct pbwc__sweep {
    pbw_memory *memory;
    size_t count, corners;                 /* corners at different places; of rings */
    pbwc__doubles x;                       /* two a place */
    pbwc__indices number, end, other;      /* per corner of rings: its place, the place where its edge ends on the
                                              right, the next edge in a list */
    pbwc__indices first, starts;           /* edges that start at place v: starts[first[v]]..starts[first[v+1]-1] */
    PBW_ARRAY(pbwc__bar) bars;             /* bar 0 is the head of the list */
    pbwc__indices unused;
    PBW_ARRAY(pbwc__piece) pieces;
    PBW_ARRAY(pbwc__way) ways;             /* at a place: ways out */
    pbwc__indices around, left;            /* at a place: pieces, counter-clockwise; those that end there */
    pbw_index path[PBWC__LEVELS];          /* the last bar below a corner, in each level */
    uint32_t state;
    pbw_rings *found;
} pbwc__sweep;

#define PBWC__PLACE(sweep, i) ((sweep)->x.at + 2 * (size_t)(i))

/* By the first of `count` numbers that differ, then by ids. */
static int pbwc__compare(const double *a, const double *b, int count, pbw_index a_id, pbw_index b_id)
{
    int k = 0;
    while (k < count && !(a[k] < b[k]) && !(a[k] > b[k])) {
        k++;
    }
    return k < count ? (a[k] < b[k] ? -1 : 1) : (a_id > b_id) - (a_id < b_id);
}

static int pbwc__compare_places(const void *left, const void *right)
{
    const pbwc__place *a = (const pbwc__place *)left, *b = (const pbwc__place *)right;
    return pbwc__compare(a->x, b->x, 2, a->corner, b->corner);
}

/* From below; all go to the right of one corner. */
static int pbwc__compare_ways(const void *a, const void *b)
{
    const pbwc__way *p = (const pbwc__way *)a, *q = (const pbwc__way *)b;
    const int turn = pbw_orient2(p->from, p->to, q->to);
    return turn != 0 ? -turn : p->edges < q->edges ? -1 : p->edges > q->edges;
}

/* Numbers places, and lists the edges that start at each. */
static pbw_status pbwc__sort_corners(pbwc__sweep *sweep, const pbw_domain *domain)
{
    const size_t corners = sweep->corners;
    PBW_ARRAY(pbwc__place) places;
    pbwc__place *place;
    pbw_index *number, *end, *other, *first, *starts;
    size_t i, r;
    memset(&places, 0, sizeof places);
    if (!PBW_FIT(sweep->memory, places, corners + 1) || !PBW_FIT(sweep->memory, sweep->x, (corners + 1) * 2)
        || !PBW_FIT(sweep->memory, sweep->number, corners + 1) || !PBW_FIT(sweep->memory, sweep->end, corners + 1)
        || !PBW_FIT(sweep->memory, sweep->other, corners + 1) || !PBW_FIT(sweep->memory, sweep->first, corners + 2)
        || !PBW_FIT(sweep->memory, sweep->starts, corners + 1)) {
        PBW_RELEASE(sweep->memory, places);
        return PBW_ERROR_MEMORY;
    }
    place = places.at;
    number = sweep->number.at;
    end = sweep->end.at;
    other = sweep->other.at;
    first = sweep->first.at;
    starts = sweep->starts.at;
    for (i = 0; i < corners; i++) {
        place[i].x = domain->rings + 2 * i;
        place[i].corner = (pbw_index)i;
    }
    qsort(place, corners, sizeof *place, pbwc__compare_places);
    for (i = 0; i < corners; i++) {
        const double *x = place[i].x;
        double *last = PBWC__PLACE(sweep, sweep->count);
        if (i == 0 || x[0] < last[-2] || x[0] > last[-2] || x[1] < last[-1] || x[1] > last[-1]) {
            memcpy(last, x, 2 * sizeof *x);
            sweep->count++;
        }
        number[place[i].corner] = (pbw_index)sweep->count - 1;
    }
    PBW_RELEASE(sweep->memory, places);
    memset(first, 0, (corners + 2) * sizeof *first);
    for (r = 0; r < domain->ring_count; r++) {
        for (i = domain->ring_first[r]; i < domain->ring_first[r + 1]; i++) {
            const pbw_index a = number[i];
            const pbw_index b = number[i + 1 < domain->ring_first[r + 1] ? i + 1 : domain->ring_first[r]];
            end[i] = a > b ? a : b;
            other[i] = a < b ? a : b;                /* where it starts; its list comes later */
            first[other[i] + 2] += a != b;
        }
    }
    for (i = 2; i < sweep->count + 2; i++) {
        first[i] += first[i - 1];
    }
    for (i = 0; i < corners; i++) {                  /* first[v + 1] moves from the begin to the end of v's */
        if (other[i] != end[i]) {
            starts[first[other[i] + 1]++] = (pbw_index)i;
        }
    }
    return PBW_OK;
}

/* Returns a bar that is not in the list; PBW_NONE if there is no memory.  Of bars of height h a quarter is higher. */
static pbw_index pbwc__new_bar(pbwc__sweep *sweep)
{
    pbw_index bar;
    uint32_t bits;
    int height = 1;
    if (sweep->unused.count > 0) {
        bar = sweep->unused.at[--sweep->unused.count];
    } else {
        if (!PBW_RESERVE(sweep->memory, sweep->bars, 1)) {
            return PBW_NONE;
        }
        bar = (pbw_index)sweep->bars.count++;
    }
    sweep->state = sweep->state * 1664525u + 1013904223u;            /* (Knuth 1997) */
    for (bits = sweep->state; height < PBWC__LEVELS && bits >> 30 == 0; bits <<= 2) {
        height++;
    }
    sweep->bars.at[bar].height = height;
    return bar;
}

/* On which side of a bar a place is: 1 above, 0 on it, -1 below. */
static int pbwc__above(const pbwc__sweep *sweep, pbw_index bar, pbw_index place)
{
    const pbwc__bar *b = sweep->bars.at + bar;
    return pbw_orient2(PBWC__PLACE(sweep, b->from), PBWC__PLACE(sweep, b->to), PBWC__PLACE(sweep, place));
}

/* Finds the last bar below a place, in each level. */
static void pbwc__find_path(pbwc__sweep *sweep, pbw_index place)
{
    pbw_index at = 0;
    int level;
    for (level = PBWC__LEVELS - 1; level >= 0; level--) {
        pbw_index next;
        while ((next = sweep->bars.at[at].next[level]) != PBW_NONE && pbwc__above(sweep, next, place) > 0) {
            at = next;
        }
        sweep->path[level] = at;
    }
}

/* Returns PBW_ERROR_ARGUMENT, with the place, if two bars cross between their ends. */
static pbw_status pbwc__check_bars(pbwc__sweep *sweep, pbw_index a, pbw_index b)
{
    const pbwc__bar *s = sweep->bars.at + a, *t = sweep->bars.at + b;
    if (a == 0 || b == PBW_NONE || pbwc__above(sweep, a, t->from) * pbwc__above(sweep, a, t->to) >= 0
        || pbwc__above(sweep, b, s->from) * pbwc__above(sweep, b, s->to) >= 0) {
        return PBW_OK;
    }
    if (sweep->found != NULL) {
        const double *p = PBWC__PLACE(sweep, s->from), *q = PBWC__PLACE(sweep, s->to);
        const double *u = PBWC__PLACE(sweep, t->from), *v = PBWC__PLACE(sweep, t->to);
        const double at_p = (v[0] - u[0]) * (p[1] - u[1]) - (v[1] - u[1]) * (p[0] - u[0]);
        const double at_q = (v[0] - u[0]) * (q[1] - u[1]) - (v[1] - u[1]) * (q[0] - u[0]);
        sweep->found->edges[0] = s->edges < t->edges ? s->edges : t->edges;
        sweep->found->edges[1] = s->edges < t->edges ? t->edges : s->edges;
        sweep->found->place[0] = p[0] + at_p / (at_p - at_q) * (q[0] - p[0]);
        sweep->found->place[1] = p[1] + at_p / (at_p - at_q) * (q[1] - p[1]);
    }
    return PBW_ERROR_ARGUMENT;
}

/* Adds a way out of a place by a list of edges, of which those that end there are left out.  Returns 0 if there is no
   memory. */
static int pbwc__add_way(pbwc__sweep *sweep, pbw_index place, pbw_index edges)
{
    pbw_index *other = sweep->other.at, next;
    const pbw_index *end = sweep->end.at;
    pbwc__way *way;
    if (!PBW_RESERVE(sweep->memory, sweep->ways, 1)) {
        return 0;
    }
    way = sweep->ways.at + sweep->ways.count;
    way->count = 0;
    way->end = place;
    way->edges = way->last = PBW_NONE;
    for (; edges != PBW_NONE; edges = next) {
        next = other[edges];
        if (end[edges] > place) {
            other[edges] = way->edges;
            way->last = way->edges == PBW_NONE ? edges : way->last;
            way->edges = edges;
            way->end = end[edges] > way->end ? end[edges] : way->end;
            way->count++;
        }
    }
    way->from = PBWC__PLACE(sweep, place);
    way->to = PBWC__PLACE(sweep, way->end);
    sweep->ways.count += way->count > 0;
    return 1;
}

/* Takes the bars that have a place, next to the path, out of the list, and ends their pieces.  Returns 0 if there is
   no memory. */
static int pbwc__take_bars(pbwc__sweep *sweep, pbw_index place)
{
    pbw_index bar;
    int level;
    sweep->left.count = 0;
    while ((bar = sweep->bars.at[sweep->path[0]].next[0]) != PBW_NONE && pbwc__above(sweep, bar, place) == 0) {
        const pbwc__bar *b = sweep->bars.at + bar;
        for (level = 0; level < b->height; level++) {
            sweep->bars.at[sweep->path[level]].next[level] = b->next[level];
        }
        if (b->piece != PBW_NONE) {
            sweep->pieces.at[b->piece].to = place;
            if (!PBW_PUSH(sweep->memory, sweep->left, b->piece)) {
                return 0;
            }
        }
        if (!pbwc__add_way(sweep, place, b->edges) || !PBW_PUSH(sweep->memory, sweep->unused, bar)) {
            return 0;
        }
    }
    return 1;
}

/* Puts a bar for a way above the path, which then ends with it.  Returns 0 if there is no memory. */
static int pbwc__put_bar(pbwc__sweep *sweep, pbw_index place, const pbwc__way *way)
{
    const pbw_index bar = pbwc__new_bar(sweep);
    const int below = bar != PBW_NONE && sweep->bars.at[sweep->path[0]].inside;
    pbwc__bar *b = sweep->bars.at + (bar != PBW_NONE ? bar : 0);
    int level;
    if (bar == PBW_NONE) {
        return 0;
    }
    b->from = place;
    b->to = way->end;
    b->edges = way->edges;
    b->piece = PBW_NONE;
    b->inside = below ^ (int)(way->count % 2);
    for (level = 0; level < b->height; level++) {
        pbwc__bar *last = sweep->bars.at + sweep->path[level];
        b->next[level] = last->next[level];
        last->next[level] = bar;
        sweep->path[level] = bar;
    }
    if (way->count % 2 != 0) {
        pbwc__piece piece;
        memset(&piece, 0, sizeof piece);
        piece.from = place;
        piece.edge = way->edges;
        piece.up = b->inside;
        b->piece = (pbw_index)sweep->pieces.count;
        if (!PBW_PUSH(sweep->memory, sweep->around, b->piece) || !PBW_PUSH(sweep->memory, sweep->pieces, piece)) {
            return 0;
        }
    }
    return 1;
}

/* Joins the pieces around a place: those to the right from below, then those to the left from above. */
static int pbwc__join_pieces(pbwc__sweep *sweep)
{
    const size_t right = sweep->around.count;
    size_t i;
    for (i = sweep->left.count; i-- > 0; ) {
        if (!PBW_PUSH(sweep->memory, sweep->around, sweep->left.at[i])) {
            return 0;
        }
    }
    for (i = 0; i < sweep->around.count; i++) {
        const pbw_index out = sweep->around.at[i];
        const pbw_index in = sweep->around.at[i + 1 < sweep->around.count ? i + 1 : 0];
        if (sweep->pieces.at[out].up == (i < right)) {            /* the inside follows it */
            sweep->pieces.at[in].then = out;
            sweep->pieces.at[in].alone = sweep->around.count == 2;
        }
    }
    return 1;
}

/* Moves the sweep across a place. */
static pbw_status pbwc__cross_place(pbwc__sweep *sweep, pbw_index place)
{
    const pbw_index *first = sweep->first.at, *starts = sweep->starts.at;
    pbw_index *other = sweep->other.at, low, i;
    pbwc__way *way;
    size_t w, ways;
    pbw_status status;
    sweep->ways.count = sweep->around.count = 0;
    pbwc__find_path(sweep, place);
    low = sweep->path[0];
    if (!pbwc__take_bars(sweep, place)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = first[place]; i < first[place + 1]; i++) {
        other[starts[i]] = PBW_NONE;
        if (!pbwc__add_way(sweep, place, starts[i])) {
            return PBW_ERROR_MEMORY;
        }
    }
    way = sweep->ways.at;
    if (sweep->ways.count > 1) {
        qsort(way, sweep->ways.count, sizeof *way, pbwc__compare_ways);
    }
    for (w = ways = 0; w < sweep->ways.count; w++) {                 /* those of one direction become one */
        if (ways > 0 && pbw_orient2(way[w].from, way[ways - 1].to, way[w].to) == 0) {
            other[way[ways - 1].last] = way[w].edges;
            way[ways - 1].last = way[w].last;
            way[ways - 1].count += way[w].count;
            way[ways - 1].to = way[w].end > way[ways - 1].end ? way[w].to : way[ways - 1].to;
            way[ways - 1].end = way[w].end > way[ways - 1].end ? way[w].end : way[ways - 1].end;
        } else {
            way[ways++] = way[w];
        }
    }
    for (w = 0; w < ways; w++) {
        if (!pbwc__put_bar(sweep, place, way + w)) {
            return PBW_ERROR_MEMORY;
        }
    }
    if (!pbwc__join_pieces(sweep)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbwc__check_bars(sweep, low, sweep->bars.at[low].next[0]);
    return status == PBW_OK && ways > 0
         ? pbwc__check_bars(sweep, sweep->path[0], sweep->bars.at[sweep->path[0]].next[0]) : status;
}

static void pbwc__sweep_end(pbwc__sweep *sweep)
{
    PBW_RELEASE(sweep->memory, sweep->x);
    PBW_RELEASE(sweep->memory, sweep->number);
    PBW_RELEASE(sweep->memory, sweep->end);
    PBW_RELEASE(sweep->memory, sweep->other);
    PBW_RELEASE(sweep->memory, sweep->first);
    PBW_RELEASE(sweep->memory, sweep->starts);
    PBW_RELEASE(sweep->memory, sweep->bars);
    PBW_RELEASE(sweep->memory, sweep->unused);
    PBW_RELEASE(sweep->memory, sweep->pieces);
    PBW_RELEASE(sweep->memory, sweep->ways);
    PBW_RELEASE(sweep->memory, sweep->around);
    PBW_RELEASE(sweep->memory, sweep->left);
}

/* Finds the pieces of the boundary; pbwc__sweep_end is due in any case.  found: what crosses, or NULL. */
static pbw_status pbwc__sweep_rings(pbw_memory *memory, const pbw_domain *domain, pbwc__sweep *sweep,
                                    pbw_rings *found)
{
    pbw_status status;
    pbw_index head, i;
    int level;
    memset(sweep, 0, sizeof *sweep);
    sweep->memory = memory;
    sweep->corners = domain->ring_first[domain->ring_count];
    sweep->found = found;
    head = pbwc__new_bar(sweep);
    status = head != PBW_NONE ? pbwc__sort_corners(sweep, domain) : PBW_ERROR_MEMORY;
    for (level = 0; level < PBWC__LEVELS && head != PBW_NONE; level++) {
        sweep->bars.at[head].next[level] = PBW_NONE;
        sweep->bars.at[head].inside = 0;
    }
    for (i = 0; status == PBW_OK && i < sweep->count; i++) {
        status = pbwc__cross_place(sweep, i);
    }
    return status == PBW_OK && sweep->pieces.count == 0 ? PBW_ERROR_ARGUMENT : status;
}

/* Where a piece starts, with the inside on its left. */
static const double *pbwc__piece_start(const pbwc__sweep *sweep, pbw_index piece)
{
    const pbwc__piece *p = sweep->pieces.at + piece;
    return PBWC__PLACE(sweep, p->up ? p->from : p->to);
}

static int pbwc__in_range(double x, double least, double most)
{
    return fabs(x) <= most && (fabs(x) >= least || !(fabs(x) > 0));
}

/* Checks the numbers of rings and the coordinates of their corners. */
static pbw_status pbwc__check_rings(const pbw_domain *domain)
{
    const size_t *first = domain->ring_first;
    size_t i;
    if (domain->rings == NULL || first == NULL || first[0] != 0) {
        return PBW_ERROR_ARGUMENT;
    }
    for (i = 0; i < domain->ring_count; i++) {
        if (first[i + 1] < first[i] || first[i + 1] >= PBW_NONE / 2) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    for (i = 0; i < 2 * first[domain->ring_count]; i++) {
        if (!pbwc__in_range(domain->rings[i], PBWC__LEAST, PBWC__MOST)) {
            return fabs(domain->rings[i]) < HUGE_VAL ? PBW_ERROR_ARGUMENT : PBW_ERROR_NOT_FINITE;
        }
    }
    return PBW_OK;
}

PBWDEF pbw_status pbw_cells_rings(const pbw_domain *domain, const pbw_options *options, pbw_rings *found)
{
    pbwc__job job;
    pbwc__sweep sweep;
    pbw_index i;
    pbw_status status;
    if (domain == NULL || found == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(found, 0, sizeof *found);
    status = pbwc__check_rings(domain);
    if (status != PBW_OK) {
        return status;
    }
    pbwc__job_start(&job, 0, options);
    status = pbwc__sweep_rings(&job.memory, domain, &sweep, found);
    for (i = 0; status == PBW_OK && i < sweep.pieces.count; i++) {
        const double *o = PBWC__PLACE(&sweep, 0), *p = pbwc__piece_start(&sweep, i);
        const double *q = pbwc__piece_start(&sweep, sweep.pieces.at[i].then);
        found->area += 0.5 * ((p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]));
    }
    pbwc__sweep_end(&sweep);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>polygons     Polygons as domains, in the plane.
     1. Each edge is followed from cell to cell: it leaves a cell across the side with one corner on its right and one
        on its left.  A visit is the part of an edge in a cell.
     2. The visits of a cell are joined to chains.
     3. Chains and parts of the cell's own sides, from where a chain leaves to where the next one enters, make loops.
     4. A cell that no edge crosses is inside or outside, as its neighbours are.
   Holds: each edge is treated as moved to its left by an infinitesimal distance, the same for all edges of a straight
   run, larger for an earlier run than for all later ones.  So the polygon is a little smaller, none of its corners
   is on the line between two cells, no edge passes through a centre, and a cell that it only touches has no part of
   it.
   In: loops of the boundary, with the inside on the left of their edges, which do not cross if moved.  Out: visits,
   by cells; for each cell without one, whether it is inside.
   ------------------------------------------------------------------------------------------------------ */
struct pbwc__visit {
    pbw_index cell, edge;
    pbw_index in, out;                     /* the cells before and after; PBW_NONE: it starts or ends here */
    double t_in, t_out;                    /* where, from 0 to 1 on the edge */
};

struct pbwc__clip {
    size_t count;                          /* corners, and edges: edge i goes from corner i to next[i] */
    pbwc__doubles x;                       /* two a corner */
    pbwc__indices name, next;              /* per corner: the edge's number in the rings; the next corner */
    pbwc__indices before, run;             /* per corner: the one before; the first edge of the straight run that the
                                              edge from it belongs to */
    pbwc__indices home, order;             /* per corner: the cell it is in; the corners along a curve */
    PBW_ARRAY(pbwc__visits) chunks;        /* visits of runs of edges */
    pbwc__visits visits;                   /* of cell v: visits first[v]..first[v+1]-1 */
    pbwc__sizes first;
    pbwc__indices root;                    /* per point: the first cell connected with it without a crossing */
    pbwc__bytes inside;                    /* bit 0, of those: they are inside; bit 1: an edge crosses into it */
};

#define PBWC__EDGES 256                    /* edges in a run */

static void pbwc__edge_ends(const pbwc__clip *clip, pbw_index edge, const double **p, const double **q)
{
    *p = clip->x.at + 2 * (size_t)edge;
    *q = clip->x.at + 2 * (size_t)clip->next.at[edge];
}

/* The sign of u.(j - i), where u leads from p to q, or (turned) of u x (j - i). */
static int pbwc__along(const pbw_mesh *mesh, const double *p, const double *q, pbw_index i, pbw_index j, int turned)
{
    const double *a = mesh->points + 2 * (size_t)i, *b = mesh->points + 2 * (size_t)j;
    pbwc__exact sum, u, d;
    int k;
    pbwc__exact_of(0, &sum);
    for (k = 0; k < 2; k++) {
        pbwc__exact_minus(q[k], p[k], &u);
        pbwc__exact_minus(b[k ^ turned], a[k ^ turned], &d);
        pbwc__exact_add_product(&sum, &u, &d, k != 0 && turned ? -1 : 1);
    }
    return sum.sign;
}

/* Returns whether a corner of the moved polygon is nearer to j (1) or to i (-1).  A corner on the line between them
   moves along the edge that moves less, or, if that lies on the line, along the other; within a run to the left, or
   ahead. */
static int pbwc__corner_side(const pbwc__clip *clip, const pbw_mesh *mesh, pbw_index corner, pbw_index i, pbw_index j)
{
    const pbw_index *before = clip->before.at, *run = clip->run.at;
    const pbw_index from = before[corner], to = clip->next.at[corner];
    const double *x = clip->x.at, *a = x + 2 * (size_t)from, *c = x + 2 * (size_t)to;
    int side, turn, along;
    x += 2 * (size_t)corner;
    side = pbwc__side(mesh, x, i, j);
    if (side != 0) {
        return side;
    }
    turn = pbw_orient2(a, x, c);
    if (turn == 0) {
        along = pbwc__along(mesh, a, x, i, j, 1);
        return along != 0 ? along : pbwc__along(mesh, a, x, i, j, 0);
    }
    if (run[from] < run[corner]) {
        along = pbwc__along(mesh, x, c, i, j, 0);
        return turn * (along != 0 ? along : -pbwc__along(mesh, a, x, i, j, 0));
    }
    along = -pbwc__along(mesh, a, x, i, j, 0);
    return turn * (along != 0 ? along : pbwc__along(mesh, x, c, i, j, 0));
}

/* Returns the neighbour to which an edge leaves the cell of v; PBW_NONE if it ends there. */
static pbw_index pbwc__exit(const pbwc__work *work, pbw_index v, pbw_index edge)
{
    const pbw_mesh *mesh = work->job->mesh;
    const pbwc__part *parts = work->parts.at;
    const pbwc__link *side = work->links.at;
    const pbw_index end = work->job->clip->next.at[edge];
    const double *p, *q;
    size_t i;
    pbwc__edge_ends(work->job->clip, edge, &p, &q);
    for (i = 0; i < work->links.count; i++, side++) {        /* centres on the edge are right of the moved one */
        if (pbwc__corner_side(work->job->clip, mesh, end, v, side->vertex) > 0
            && (side->from < 0 || pbwc__centre_side(mesh, p, q, parts[side->from].simplex) <= 0)
            && (side->to < 0 || pbwc__centre_side(mesh, p, q, parts[side->to].simplex) > 0)) {
            return side->vertex;
        }
    }
    return PBW_NONE;
}

/* Where an edge crosses the line between two cells, from 0 to 1. */
static double pbwc__crossing(const pbwc__clip *clip, const pbw_mesh *mesh, pbw_index edge, pbw_index a, pbw_index b)
{
    const pbw_index i = a < b ? a : b, j = a < b ? b : a;            /* the same bits from both sides */
    const double *p, *q;
    double at_p, at_q, size, t;
    pbwc__edge_ends(clip, edge, &p, &q);
    at_p = pbwc__side(mesh, p, i, j) == 0 ? 0 : pbwc__closer(mesh, p, i, j, &size);
    at_q = pbwc__side(mesh, q, i, j) == 0 ? 0 : pbwc__closer(mesh, q, i, j, &size);
    t = at_p / (at_p - at_q);
    return t > 0 ? t < 1 ? t : 1 : 0;                                /* 0 also where both are 0 */
}

/* The cells that an edge visits.  Returns 0 if there is no memory. */
static int pbwc__follow(pbwc__work *work, pbw_index edge, pbwc__visits *visits)
{
    const pbwc__clip *clip = work->job->clip;
    size_t steps = 0;
    pbwc__visit visit;
    visit.cell = clip->home.at[edge];
    visit.in = PBW_NONE;
    visit.t_in = 0;
    do {
        if (!pbwc__gather(work, visit.cell)) {
            return 0;
        }
        visit.edge = edge;
        visit.out = pbwc__exit(work, visit.cell, edge);
        visit.t_out = visit.out == PBW_NONE ? 1
                    : pbwc__crossing(clip, work->job->mesh, edge, visit.cell, visit.out);
        if (!PBW_PUSH(work->memory, *visits, visit)) {
            return 0;
        }
        visit.in = visit.cell;
        visit.t_in = visit.t_out;
        visit.cell = visit.out;
    } while (visit.cell != PBW_NONE && steps++ < work->job->count);
    return 1;
}

static pbw_status pbwc__follow_edges(void *arg, size_t from, size_t to)
{
    pbwc__job *job = (pbwc__job *)arg;
    pbwc__clip *clip = job->clip;
    pbwc__work work;
    int good = pbwc__work_start(&work, job);
    pbwc__visits *visits = clip->chunks.at + from / PBWC__EDGES;
    for (; good && from < to; from++) {
        good = pbwc__follow(&work, (pbw_index)from, visits);
    }
    pbwc__work_end(&work);
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Returns a vertex near p: the nearest of a few. */
static pbw_index pbwc__vertex_near(const pbw_mesh *mesh, const double *p)
{
    const size_t step = mesh->point_count / 64 + 1;
    pbw_index nearest = mesh->simplices[0];
    double size;
    size_t i;
    for (i = 0; i < mesh->point_count; i += step) {
        if (mesh->incident[i] != PBW_NONE && pbwc__closer(mesh, p, nearest, (pbw_index)i, &size) > 0) {
            nearest = (pbw_index)i;
        }
    }
    return nearest;
}

/* Finds the cells of the polygon's corners: steps to nearer vertices, from the cell of the corner before on a
   curve. */
static pbw_status pbwc__find_own_cells(void *arg, size_t from, size_t to)
{
    pbwc__job *job = (pbwc__job *)arg;
    const pbw_mesh *mesh = job->mesh;
    pbw_index *home = job->clip->home.at, *order = job->clip->order.at;
    pbw_index then = pbwc__vertex_near(mesh, job->clip->x.at + 2 * (size_t)order[from]);
    pbwc__work work;
    int good = pbwc__work_start(&work, job);
    for (; good && from < to; from++) {
        const pbw_index corner = order[from];
        pbw_index at;
        do {
            size_t u;
            at = then;
            good = pbwc__gather(&work, at);
            for (u = 0; good && u < work.links.count; u++) {
                const pbw_index other = work.links.at[u].vertex;
                then = pbwc__corner_side(job->clip, mesh, corner, then, other) > 0 ? other : then;
            }
        } while (good && then != at);
        home[corner] = at;
    }
    pbwc__work_end(&work);
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* ---- the loops of the boundary */

static int pbwc__is_at(const double *a, const double *b)
{
    return a[0] >= b[0] && a[0] <= b[0] && a[1] >= b[1] && a[1] <= b[1];
}

/* Checks that no product can over- or underflow. */
static pbw_status pbwc__check_polygon(const pbw_mesh *mesh, const pbw_domain *domain)
{
    size_t i;
    if (mesh->dim != 2 || domain->box != NULL || domain->plane_count != 0) {
        return PBW_ERROR_ARGUMENT;
    }
    for (i = 0; i < mesh->point_count; i++) {
        if (!pbwc__in_range(mesh->points[2 * i], PBWC__LEAST, PBWC__MOST)
            || !pbwc__in_range(mesh->points[2 * i + 1], PBWC__LEAST, PBWC__MOST)
            || !pbwc__in_range(pbwc__weight(mesh, (pbw_index)i), PBWC__LEAST * PBWC__LEAST,
                               PBWC__MOST * PBWC__MOST)) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    return pbwc__check_rings(domain);
}

/* Copies the loop of a piece, from its lowest corner, where it turns.  Pieces of one edge with no other loop between
   them become one. */
static void pbwc__copy_loop(pbwc__clip *clip, pbwc__sweep *sweep, pbw_index piece)
{
    pbw_index *before = clip->before.at, *next = clip->next.at;
    pbw_index *run = clip->run.at, at = piece, start = piece;
    const pbw_index first = (pbw_index)clip->count;
    const double *x = clip->x.at;
    do {                                             /* places are in order */
        if (pbwc__piece_start(sweep, at) < pbwc__piece_start(sweep, start)) {
            start = at;
        }
        sweep->pieces.at[at].done = 1;
        at = sweep->pieces.at[at].then;
    } while (at != piece);
    at = start;
    do {
        const pbwc__piece *p = sweep->pieces.at + at;
        const pbw_index then = p->then;
        memcpy(clip->x.at + 2 * clip->count, pbwc__piece_start(sweep, at), 2 * sizeof(double));
        clip->name.at[clip->count] = p->edge;
        for (at = then; p->alone && at != start && sweep->pieces.at[at].edge == p->edge; ) {
            p = sweep->pieces.at + at;
            at = p->then;
        }
        before[clip->count] = (pbw_index)clip->count - 1;
        next[clip->count] = (pbw_index)clip->count + 1;
        clip->count++;
    } while (at != start);
    before[first] = (pbw_index)clip->count - 1;
    next[clip->count - 1] = first;
    for (at = first; at < clip->count; at++) {
        run[at] = pbw_orient2(x + 2 * (size_t)before[at], x + 2 * (size_t)at, x + 2 * (size_t)next[at]) == 0
                ? run[at - 1] : at;
    }
}

/* Makes the corners of the polygon's boundary. */
static pbw_status pbwc__copy_rings(pbwc__job *job, const pbw_domain *domain)
{
    pbwc__clip *clip = job->clip;
    pbwc__sweep sweep;
    pbw_index i;
    pbw_status status = pbwc__sweep_rings(&job->memory, domain, &sweep, NULL);
    const size_t pieces = sweep.pieces.count;
    if (status == PBW_OK
        && (!PBW_FIT(&job->memory, clip->x, pieces * 2) || !PBW_FIT(&job->memory, clip->name, pieces)
            || !PBW_FIT(&job->memory, clip->next, pieces) || !PBW_FIT(&job->memory, clip->before, pieces)
            || !PBW_FIT(&job->memory, clip->run, pieces) || !PBW_FIT(&job->memory, clip->home, pieces))) {
        status = PBW_ERROR_MEMORY;
    }
    for (i = 0; status == PBW_OK && i < pieces; i++) {
        if (!sweep.pieces.at[i].done) {
            pbwc__copy_loop(clip, &sweep, i);
        }
    }
    pbwc__sweep_end(&sweep);
    return status;
}

/* ---- all visits, by cells; cells that are connected without crossings */

/* The visits of each cell, in the order of the edges. */
static pbw_status pbwc__sort_visits(pbwc__job *job)
{
    pbwc__clip *clip = job->clip;
    size_t c, i, sum = 0, *first;
    if (!PBW_ZEROS(&job->memory, clip->first, job->count + 2)) {
        return PBW_ERROR_MEMORY;
    }
    first = clip->first.at;
    for (c = 0; c < clip->chunks.count; c++) {
        const pbwc__visits *chunk = clip->chunks.at + c;
        for (i = 0; i < chunk->count; i++) {
            first[chunk->at[i].cell + 2]++;
        }
        sum += chunk->count;
    }
    if (!PBW_FIT(&job->memory, clip->visits, sum + 1)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 2; i < job->count + 2; i++) {
        first[i] += first[i - 1];
    }
    for (c = 0; c < clip->chunks.count; c++) {       /* first[v + 1] moves from the begin to the end of v's */
        const pbwc__visits *chunk = clip->chunks.at + c;
        for (i = 0; i < chunk->count; i++) {
            const pbwc__visit *visit = chunk->at + i;
            clip->visits.at[first[visit->cell + 1]++] = *visit;
        }
    }
    return PBW_OK;
}

static const pbwc__visit *pbwc__visits_of(const pbwc__clip *clip, size_t v, size_t *count)
{
    const size_t *first = clip->first.at;
    *count = first[v + 1] - first[v];
    return clip->visits.at + first[v];
}

/* Joins neighbours that no edge crosses; marks those that one does. */
static pbw_status pbwc__connect(pbwc__job *job)
{
    const pbw_mesh *mesh = job->mesh;
    pbwc__clip *clip = job->clip;
    unsigned char *inside;
    pbw_index *root;
    size_t i, k, count;
    if (!PBW_FIT(&job->memory, clip->root, job->count + 1) || !PBW_FIT(&job->memory, clip->inside, job->count + 1)) {
        return PBW_ERROR_MEMORY;
    }
    root = clip->root.at;
    inside = clip->inside.at;
    for (i = 0; i < job->count; i++) {
        const pbwc__visit *visit = pbwc__visits_of(clip, i, &count);
        root[i] = (pbw_index)i;
        inside[i] = 0;
        for (k = 0; k < count; k++) {
            inside[i] |= visit[k].in != PBW_NONE || visit[k].out != PBW_NONE ? 2 : 0;
        }
    }
    for (i = 0; i < 3 * mesh->simplex_count; i++) {
        const pbw_index a = mesh->simplices[i], b = mesh->simplices[i % 3 < 2 ? i + 1 : i - 2];
        if (a < job->count && b < job->count && inside[a] == 0 && inside[b] == 0) {
            const pbw_index x = pbwc__root(root, a), y = pbwc__root(root, b);
            root[x > y ? x : y] = x > y ? y : x;
        }
    }
    for (i = 0; i < job->count; i++) {
        root[i] = pbwc__root(root, (pbw_index)i);
    }
    return PBW_OK;
}

/* ------------------------------------------------------------------------------------------------------
   >>chains       One cell of a polygon: its visits joined to chains, chains and its own sides to loops.
   In: a cell's star and visits.  Out: its loops, facets and moments.
   ------------------------------------------------------------------------------------------------------ */

/* Returns 1 if the sector of the inside at a corner has the ray from there along u, -1 if the opposite ray, else 0.
   u leads counter-clockwise along the side between the cells of i and j, as seen from i. */
static int pbwc__sector_side(const pbwc__clip *clip, const pbw_mesh *mesh, pbw_index corner, pbw_index i, pbw_index j)
{
    const double *x = clip->x.at, *at = x + 2 * (size_t)corner;
    const double *p = x + 2 * (size_t)clip->before.at[corner];
    const double *q = x + 2 * (size_t)clip->next.at[corner];
    const int turn = pbw_orient2(p, at, q), to_q = pbwc__along(mesh, at, q, i, j, 0);
    const int to_p = pbwc__along(mesh, at, p, i, j, 0);              /* the signs of (q - at) x u and (p - at) x u */
    const int forward = turn > 0 ? to_q > 0 && to_p < 0 : turn < 0 ? to_q > 0 || to_p < 0 : to_q > 0;
    const int backward = turn > 0 ? to_q < 0 && to_p > 0 : turn < 0 ? to_q < 0 || to_p > 0 : to_q < 0;
    return forward - backward;
}

/* Returns 1 if end a comes before b where loops touch in a corner on the side between two cells, -1 if after it, 0 if
   they do not touch there.  Their sectors have nothing in common, so one has one ray of the side, one the other. */
static int pbwc__touching_ends(const pbwc__work *work, pbw_index beyond, pbw_index e, pbw_index f)
{
    const pbwc__clip *clip = work->job->clip;
    const pbw_index *next = clip->next.at;
    const double *x = clip->x.at;
    int i, side;
    for (i = 0; i < 4; i++) {
        const pbw_index a = i % 2 != 0 ? next[e] : e, b = i / 2 != 0 ? next[f] : f;
        if (a != b && pbwc__is_at(x + 2 * (size_t)a, x + 2 * (size_t)b)
            && pbwc__side(work->job->mesh, x + 2 * (size_t)a, work->site, beyond) == 0) {
            side = pbwc__sector_side(clip, work->job->mesh, a, work->site, beyond);
            side = side != 0 ? -side : pbwc__sector_side(clip, work->job->mesh, b, work->site, beyond);
            if (side != 0) {
                return side;
            }
        }
    }
    return 0;
}

/* Returns whether end a comes before b, counter-clockwise, on one side.  Edges do not cross, so both corners of one
   edge are on one side of the other. */
static int pbwc__end_before(const pbwc__work *work, const pbwc__end *a, const pbwc__end *b)
{
    const pbwc__clip *clip = work->job->clip;
    const pbwc__visit *visit = work->visits;
    const double *p, *q, *r, *s, *t;
    int low, high;
    pbwc__edge_ends(clip, visit[a->visit].edge, &p, &q);
    pbwc__edge_ends(clip, visit[b->visit].edge, &r, &s);
    if (a->side != b->side) {
        return a->side < b->side;
    }
    low = pbwc__touching_ends(work, work->links.at[a->side].vertex, visit[a->visit].edge, visit[b->visit].edge);
    if (low != 0) {
        return low > 0;
    }
    if (!a->leaves) {                                /* all outward */
        t = p, p = q, q = t;
    }
    if (!b->leaves) {
        t = r, r = s, s = t;
    }
    low = pbw_orient2(p, q, r);
    high = pbw_orient2(p, q, s);
    if (low * high >= 0 && (low != 0 || high != 0)) {
        return low + high > 0;
    }
    low = pbw_orient2(r, s, p);
    high = pbw_orient2(r, s, q);
    return low + high != 0 ? low + high < 0 : a->leaves != b->leaves ? !a->leaves : a->visit < b->visit;
}

static void pbwc__sift(const pbwc__work *work, pbwc__end *ends, size_t at, size_t count)
{
    size_t child;
    for (; (child = 2 * at + 1) < count; at = child) {
        const pbwc__end swap = ends[at];
        child += child + 1 < count && pbwc__end_before(work, ends + child, ends + child + 1);
        if (!pbwc__end_before(work, &swap, ends + child)) {
            break;
        }
        ends[at] = ends[child];
        ends[child] = swap;
    }
}

static int pbwc__add_end(pbwc__work *work, pbw_index beyond, size_t visit, int leaves)
{
    pbwc__end end;
    end.side = pbwc__number(work->memory, &work->numbers, beyond, 0);
    end.leaves = leaves;
    end.visit = (int)visit;
    return end.side >= 0 && PBW_PUSH(work->memory, work->ends, end);
}

/* Gathers the star of v and where chains end on its sides, counter-clockwise.  Returns 0 if there is no memory. */
static int pbwc__find_ends(pbwc__work *work, pbw_index v)
{
    const pbwc__visit *visit = pbwc__visits_of(work->job->clip, v, &work->visit_count);
    pbwc__end *ends;
    size_t i;
    work->visits = visit;
    work->ends.count = 0;
    if (!pbwc__gather(work, v)) {
        return 0;
    }
    pbwc__map_clear(&work->numbers);
    for (i = 0; i < work->links.count; i++) {
        if (pbwc__number(work->memory, &work->numbers, work->links.at[i].vertex, (int)i) < 0) {
            return 0;
        }
    }
    for (i = 0; i < work->visit_count; i++) {
        if ((visit[i].in != PBW_NONE && !pbwc__add_end(work, visit[i].in, i, 0))
            || (visit[i].out != PBW_NONE && !pbwc__add_end(work, visit[i].out, i, 1))) {
            return 0;
        }
    }
    ends = work->ends.at;
    for (i = work->ends.count / 2; i-- > 0; ) {
        pbwc__sift(work, ends, i, work->ends.count);
    }
    for (i = work->ends.count; i-- > 1; ) {
        const pbwc__end swap = ends[0];
        ends[0] = ends[i];
        ends[i] = swap;
        pbwc__sift(work, ends, 0, i);
    }
    return 1;
}

/* Marks uncrossed neighbours of crossed cells: such a neighbour is inside if the side between them is. */
static pbw_status pbwc__classify_neighbors(void *arg, size_t from, size_t to)
{
    pbwc__job *job = (pbwc__job *)arg;
    unsigned char *inside = job->clip->inside.at;
    pbwc__work work;
    int good = pbwc__work_start(&work, job);
    for (; good && from < to; from++) {
        const pbwc__end *end;
        size_t i, at;
        if ((PBW_ATOMIC_LOAD(inside + from) & 2) == 0) {
            continue;
        }
        good = pbwc__find_ends(&work, (pbw_index)from);
        end = work.ends.at;
        for (i = at = 0; good && i < work.links.count; i++) {
            const pbw_index other = work.links.at[i].vertex;
            while (at < work.ends.count && end[at].side <= (int)i) {
                at++;
            }
            if (other < job->count && (PBW_ATOMIC_LOAD(inside + other) & 2) == 0
                && end[at > 0 ? at - 1 : work.ends.count - 1].leaves) {
                unsigned char *mark = inside + job->clip->root.at[other];
                PBW_ATOMIC_STORE(mark, 1);                /* threads may write the same */
            }
        }
    }
    pbwc__work_end(&work);
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* A corner at the end of the loop.  Returns NULL if there is no memory. */
static pbwc__corner *pbwc__add_corner(pbwc__work *work)
{
    pbwc__corner *corner;
    if (!PBW_RESERVE(work->memory, work->loop, 1)) {
        return NULL;
    }
    corner = work->loop.at + work->loop.count++;
    corner->part = -1;
    corner->ring = corner->edge = PBW_NONE;
    return corner;
}

static int pbwc__add_ring_corner(pbwc__work *work, pbw_index v, pbw_index at)
{
    const double *site = work->job->mesh->points + 2 * (size_t)v;
    const double *x = work->job->clip->x.at + 2 * (size_t)at;
    pbwc__corner *corner = pbwc__add_corner(work);
    if (corner == NULL) {
        return 0;
    }
    corner->x[0] = x[0] - site[0];
    corner->x[1] = x[1] - site[1];
    corner->ring = corner->edge = at;
    return 1;
}

static int pbwc__add_centre(pbwc__work *work, int part, int link)
{
    pbwc__corner *corner = pbwc__add_corner(work);
    if (corner == NULL) {
        return 0;
    }
    memcpy(corner->x, work->parts.at[part].centre, 2 * sizeof(double));
    corner->part = part;
    corner->link = link;
    return 1;
}

/* Adds the place where a chain ends; if this is a corner of the polygon or of the cell, exactly that place. */
static int pbwc__add_crossing(pbwc__work *work, pbw_index v, const pbwc__end *end)
{
    const pbw_mesh *mesh = work->job->mesh;
    const pbwc__clip *clip = work->job->clip;
    const pbwc__visit *visit = work->visits + end->visit;
    const pbwc__link *side = work->links.at + end->side;
    const double t = end->leaves ? visit->t_out : visit->t_in, *site = mesh->points + 2 * (size_t)v;
    const double *p, *q, *at = NULL;
    const pbw_index beyond = side->vertex;
    pbwc__corner *corner = pbwc__add_corner(work);
    int k;
    if (corner == NULL) {
        return 0;
    }
    pbwc__edge_ends(clip, visit->edge, &p, &q);
    corner->edge = end->leaves ? PBW_NONE : visit->edge;
    corner->link = end->side;
    if (pbwc__side(mesh, p, v, beyond) == 0) {
        corner->ring = visit->edge;
        at = p;
    } else if (pbwc__side(mesh, q, v, beyond) == 0) {
        corner->ring = clip->next.at[visit->edge];
        at = q;
    }
    if (side->from >= 0 && pbwc__centre_side(mesh, p, q, work->parts.at[side->from].simplex) == 0) {
        corner->part = side->from;
    } else if (side->to >= 0 && pbwc__centre_side(mesh, p, q, work->parts.at[side->to].simplex) == 0) {
        corner->part = side->to;
    }
    for (k = 0; k < 2; k++) {
        corner->x[k] = corner->part >= 0 ? work->parts.at[corner->part].centre[k]
                     : at != NULL ? at[k] - site[k] : (p[k] - site[k]) + t * (q[k] - p[k]);
    }
    return 1;
}

/* The visit of the edge after this one's, in this cell; -1 if there is none. */
static int pbwc__next_visit(const pbwc__work *work, int visit)
{
    const pbw_index edge = work->job->clip->next.at[work->visits[visit].edge];
    size_t low = 0, high = work->visit_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (work->visits[middle].edge < edge) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < work->visit_count && work->visits[low].edge == edge && work->visits[low].in == PBW_NONE ? (int)low
         : -1;
}

/* Follows the sides of the cell from one end to the next one, which must enter. */
static pbw_status pbwc__along_sides(pbwc__work *work, size_t end)
{
    const pbwc__end *ends = work->ends.at, *from = ends + end;
    const pbwc__end *to = ends + (end + 1 < work->ends.count ? end + 1 : 0);
    const pbwc__link *links = work->links.at;
    int side = from->side, steps = to->side - side;
    if (to->leaves) {
        return PBW_ERROR_ARGUMENT;                   /* rings cross */
    }
    for (steps += steps < 0 || to <= from ? (int)work->links.count : 0; steps > 0; steps--) {
        const int part = links[side].to;
        side = side + 1 < (int)work->links.count ? side + 1 : 0;
        if (part < 0) {
            return PBW_ERROR_ARGUMENT;
        }
        if (!pbwc__add_centre(work, part, side)) {
            return PBW_ERROR_MEMORY;
        }
    }
    return PBW_OK;
}

static int pbwc__same_corner(const pbwc__work *work, const pbwc__corner *a, const pbwc__corner *b)
{
    const pbw_index *merged = work->job->merged.at;
    const double *x = work->job->clip->x.at;
    if (a->part >= 0 && b->part >= 0) {
        const pbw_index s = work->parts.at[a->part].simplex, t = work->parts.at[b->part].simplex;
        return s == t || (merged != NULL && merged[s] == merged[t]);
    }
    return a->ring != PBW_NONE && b->ring != PBW_NONE
           && pbwc__is_at(x + 2 * (size_t)a->ring, x + 2 * (size_t)b->ring);
}

/* Joins two corners at one place: a gets what is known of both, and the continuation of b. */
static void pbwc__join_corners(pbwc__corner *a, const pbwc__corner *b)
{
    if (a->part < 0 && (b->part >= 0 || a->ring == PBW_NONE)) {
        memcpy(a->x, b->x, sizeof a->x);
        a->part = b->part;
    }
    a->ring = a->ring != PBW_NONE ? a->ring : b->ring;
    a->edge = b->edge;
    a->link = b->link;
}

/* Ends the loop from corner `begin`; removes edges without length. */
static void pbwc__end_loop(pbwc__work *work, size_t begin)
{
    pbwc__corner *loop = work->loop.at + begin;
    size_t i, count = 0;
    for (i = begin; i < work->loop.count; i++) {
        const pbwc__corner *corner = work->loop.at + i;
        if (count > 0 && pbwc__same_corner(work, loop + count - 1, corner)) {
            pbwc__join_corners(loop + count - 1, corner);
        } else {
            loop[count++] = *corner;
        }
    }
    while (count > 1 && pbwc__same_corner(work, loop + count - 1, loop)) {
        pbwc__join_corners(loop + count - 1, loop);
        loop[0] = loop[count - 1];
        count--;
    }
    work->loop.count = count < 3 ? begin : begin + count;
}

/* The loop of which a visit is part.  Returns a status. */
static pbw_status pbwc__trace(pbwc__work *work, pbw_index v, int visit)
{
    const size_t begin = work->loop.count;
    unsigned char *used = work->used.at;
    const int start = visit;
    pbw_status status = PBW_OK;
    do {
        const pbwc__visit *at = work->visits + visit;
        int then = -1;
        if (used[visit]) {
            return PBW_ERROR_ARGUMENT;
        }
        used[visit] = 1;
        if (at->in != PBW_NONE && !pbwc__add_crossing(work, v, work->ends.at + work->end_of.at[2 * visit])) {
            return PBW_ERROR_MEMORY;
        }
        if (at->in == PBW_NONE && !pbwc__add_ring_corner(work, v, at->edge)) {
            return PBW_ERROR_MEMORY;
        }
        if (at->out == PBW_NONE) {
            then = pbwc__next_visit(work, visit);
        } else {
            const size_t end = work->end_of.at[2 * visit + 1];
            if (!pbwc__add_crossing(work, v, work->ends.at + end)) {
                return PBW_ERROR_MEMORY;
            }
            status = pbwc__along_sides(work, end);
            then = work->ends.at[end + 1 < work->ends.count ? end + 1 : 0].visit;
        }
        visit = then;
    } while (status == PBW_OK && visit >= 0 && visit != start);
    pbwc__end_loop(work, begin);
    return status == PBW_OK && visit < 0 ? PBW_ERROR_ARGUMENT : status;
}

/* Returns whether a cell that no edge crosses is inside, apart from rings within it. */
static int pbwc__is_inside(const pbwc__clip *clip, pbw_index v)
{
    return clip->inside.at[clip->root.at[v]] & 1;
}

/* All loops of the cell of v; in work->loop, where each begins in work->begins.  Returns a status. */
static pbw_status pbwc__find_loops(pbwc__work *work, pbw_index v)
{
    unsigned char *used;
    size_t i, pass;
    pbw_status status = PBW_OK;
    work->loop.count = work->begins.count = work->used.count = work->end_of.count = 0;
    if (!PBW_RESERVE(work->memory, work->used, work->visit_count + 1)
        || !PBW_RESERVE(work->memory, work->end_of, 2 * work->visit_count + 1)) {
        return PBW_ERROR_MEMORY;
    }
    used = work->used.at;
    memset(used, 0, work->visit_count);
    for (i = 0; i < work->ends.count; i++) {
        work->end_of.at[2 * work->ends.at[i].visit + work->ends.at[i].leaves] = i;
    }
    if (work->ends.count == 0 && pbwc__is_inside(work->job->clip, v)) {
        if (!PBW_PUSH(work->memory, work->begins, 0)) {
            return PBW_ERROR_MEMORY;
        }
        for (i = 0; i < work->links.count; i++) {    /* all of the cell, around what rings cut from it */
            const pbwc__link *side = work->links.at + i;
            if (side->from < 0 || !pbwc__add_centre(work, side->from, (int)i)) {
                return side->from < 0 ? PBW_ERROR_ARGUMENT : PBW_ERROR_MEMORY;
            }
        }
        pbwc__end_loop(work, 0);
    }
    for (pass = 0; pass < 2; pass++) {               /* chains that enter, then rings within the cell */
        for (i = 0; status == PBW_OK && i < work->visit_count; i++) {
            const pbw_index begin = (pbw_index)work->loop.count;
            if (!used[i] && (pass == 1 || work->visits[i].in != PBW_NONE)) {
                status = PBW_PUSH(work->memory, work->begins, begin) ? pbwc__trace(work, v, (int)i)
                       : PBW_ERROR_MEMORY;
            }
        }
    }
    return status;
}

/* The vertex of a corner: a centre, or one of the range's own.  PBW_NONE: no memory. */
static pbw_index pbwc__corner_vertex(pbwc__work *work, pbw_index v, const pbwc__corner *corner)
{
    const pbw_mesh *mesh = work->job->mesh;
    const pbw_index *merged = work->job->merged.at;
    double x[2];
    pbw_index number;
    int k;
    if (corner->part >= 0) {
        const pbw_index simplex = work->parts.at[corner->part].simplex;
        return merged != NULL ? merged[simplex] : simplex;
    }
    for (k = 0; k < 2; k++) {
        x[k] = corner->ring != PBW_NONE ? work->job->clip->x.at[2 * (size_t)corner->ring + (size_t)k]
             : mesh->points[2 * (size_t)v + (size_t)k] + corner->x[k];
    }
    number = pbwc__push_vector(work, &work->out->vertices, x);
    return number == PBW_NONE ? PBW_NONE : (pbw_index)mesh->simplex_count + number;
}

/* Adds a loop's area and moments to sum, and its sides to the facets.  Returns 0 if there is no memory. */
static int pbwc__loop_out(pbwc__work *work, pbw_index v, size_t begin, size_t end, double *sum)
{
    const pbwc__corner *loop = work->loop.at;
    const int shapes = (work->job->what & PBW_CELLS_SHAPES) != 0;
    const pbw_index first = shapes ? pbwc__corner_vertex(work, v, loop + begin) : 0;
    pbw_index from = first, to;
    size_t i;
    for (i = begin; i < end && (work->job->what & PBW_CELLS_FACETS) != 0; i++, from = to) {
        const pbwc__corner *a = loop + i, *b = loop + (i + 1 < end ? i + 1 : begin);
        const double x = b->x[0] - a->x[0], y = b->x[1] - a->x[1];
        const size_t entries = work->out->loops.count;
        to = !shapes || i + 1 == end ? first : pbwc__corner_vertex(work, v, b);
        if (shapes && (from == PBW_NONE || to == PBW_NONE || !PBW_PUSH(work->memory, work->out->loops, from)
                       || !PBW_PUSH(work->memory, work->out->loops, to))) {
            return 0;
        }
        if (!pbwc__facet_done(work, a->edge != PBW_NONE
                              ? PBW_NONE - 1 - work->job->clip->name.at[a->edge]
                              : work->links.at[a->link].vertex, sqrt(x * x + y * y), entries)) {
            return 0;
        }
    }
    for (i = begin + 1; i + 1 < end; i++) {
        const double *o = loop[begin].x, *a = loop[i].x, *b = loop[i + 1].x;
        const double w = (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
        sum[3] += w;
        sum[0] += w * (o[0] + a[0] + b[0]);
        sum[1] += w * (o[1] + a[1] + b[1]);
    }
    return 1;
}

/* The cell of v within the polygon.  Returns a status. */
static pbw_status pbwc__clip_cell(pbwc__work *work, pbw_index v)
{
    pbwc__job *job = work->job;
    double sum[4] = { 0, 0, 0, 0 };
    size_t i;
    pbw_status status;
    (void)pbwc__visits_of(job->clip, v, &work->visit_count);
    if (work->visit_count == 0) {
        if (!pbwc__is_inside(job->clip, v)) {
            pbwc__set_cell(job, v, sum);
            return PBW_OK;
        }
        if (!pbwc__gather(work, v)) {
            return PBW_ERROR_MEMORY;
        }
        return !pbwc__star_volume(work) ? PBW_ERROR_ARGUMENT
               : (job->what & PBW_CELLS_FACETS) == 0 || pbwc__star_facets(work) ? PBW_OK : PBW_ERROR_MEMORY;
    }
    if (!pbwc__find_ends(work, v)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbwc__find_loops(work, v);
    for (i = 0; status == PBW_OK && i < work->begins.count; i++) {
        const size_t begin = work->begins.at[i];
        const size_t end = i + 1 < work->begins.count ? work->begins.at[i + 1] : work->loop.count;
        status = pbwc__loop_out(work, v, begin, end, sum) ? PBW_OK : PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        pbwc__set_cell(job, v, sum);
    }
    return status;
}

/* Finds out which cells the polygon's edges visit, and which are inside of it. */
static pbw_status pbwc__start_clip(pbwc__job *job)
{
    const pbw_options *options = &job->options;
    pbwc__clip *clip = job->clip;
    pbw_status status;
    if (!PBW_FIT(&job->memory, clip->order, clip->count)
        || !PBW_ZEROS(&job->memory, clip->chunks, (clip->count + PBWC__EDGES - 1) / PBWC__EDGES)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbw_order(2, clip->x.at, clip->count, options, clip->order.at);
    status = status == PBW_OK ? pbw_for(options, clip->count, PBWC__EDGES, pbwc__find_own_cells, job) : status;
    PBW_RELEASE(&job->memory, clip->order);
    status = status == PBW_OK ? pbw_for(options, clip->count, PBWC__EDGES, pbwc__follow_edges, job) : status;
    status = status == PBW_OK ? pbwc__sort_visits(job) : status;
    status = status == PBW_OK ? pbwc__connect(job) : status;
    return status == PBW_OK ? pbw_for(options, job->count, 2048, pbwc__classify_neighbors, job) : status;
}

static void pbwc__end_clip(pbwc__job *job)
{
    pbwc__clip *clip = job->clip;
    size_t i;
    for (i = 0; i < clip->chunks.count; i++) {
        PBW_RELEASE(&job->memory, clip->chunks.at[i]);
    }
    PBW_RELEASE(&job->memory, clip->chunks);
    PBW_RELEASE(&job->memory, clip->x);
    PBW_RELEASE(&job->memory, clip->name);
    PBW_RELEASE(&job->memory, clip->next);
    PBW_RELEASE(&job->memory, clip->before);
    PBW_RELEASE(&job->memory, clip->run);
    PBW_RELEASE(&job->memory, clip->home);
    PBW_RELEASE(&job->memory, clip->order);
    PBW_RELEASE(&job->memory, clip->visits);
    PBW_RELEASE(&job->memory, clip->first);
    PBW_RELEASE(&job->memory, clip->root);
    PBW_RELEASE(&job->memory, clip->inside);
}

/* ------------------------------------------------------------------------------------------------------
   >>periodic     Periodic boxes and lattices: which copies of points the cells need.
   In: the cells of a round.  Out: marks where copies are missing, or the missing copies.
   The cells are those of the points in a mesh that also has copies of them beyond the walls of the box.  Copies are
   exact translates, as coordinates and box sizes are multiples of one power of two per axis.
   The copies are certainly enough: a missing copy could change a cell only if it takes one of the cell's corners,
   that is, if it lies in the ball around that corner that reaches to the site (with weights, the squared radius is
   the corner's power distance plus the largest weight).  Balls that leave the padded box mark a grid, and the copies
   there are added.  A cell that shrinks has smaller balls, in the union of its old ones, so a second round is the
   last.  If points are clustered, balls in the empty parts are large and would add most copies; then a few copies,
   one point of each cell of a coarse grid, shrink them first.  Once marks add no copy, none is missing.
   In a long box balls may be many periods wide and reach beyond the grid, which then marks far too much.  So they are
   searched instead: of each cell the copy that is deepest in one of its balls is added, until no ball has one.  A
   search goes through the periods of the longest axis first, nearest first, then the next axis's, then through a tree
   of boxes around the points, and leaves out what is farther than the deepest copy so far.  The radius has the same
   allowance for rounding as with marks, 1e-9 of itself, so a ball holds its site, which is there, and copies that are
   as near up to rounding.
   Along a periodic axis a cell reaches at most half the box from its site, as its images have the rest; so it is cut
   from a box of 3/4 to each side.
   A lattice: all of that with heights instead of coordinates, which are distances from the faces of a parallelepiped,
   that of its reduced vectors.  Vector k adds its height to the k-th one and 0 to the others, and two points are as
   far apart as their heights or further, so balls are between two heights.  A cell lies in that of the lattice
   itself, which reaches at most half the sum of the vectors' lengths: each point is so near to a sum of whole
   vectors.
   ------------------------------------------------------------------------------------------------------ */

/* How far x lies along the k-th axis, or of a lattice from the k-th face. */
PBW_INLINE double pbwc__height(const pbwc__period *period, int k, const double *x)
{
    const double *n = period->normal[k];
    return !period->is_lattice ? x[k] : n[0] * x[0] + n[1] * x[1] + (period->dim == 3 ? n[2] * x[2] : 0);
}

/* The cell of the grid along axis k. */
static int pbwc__grid_at(const pbwc__period *period, int k, double height)
{
    const double at = (height - period->grid[k]) / period->step[k];
    return !(at > 0) ? 0 : at >= PBWC__GRID ? PBWC__GRID - 1 : (int)at;
}

static unsigned char *pbwc__grid_mark(const pbwc__period *period, const int at[3])
{
    return period->marks.at + ((size_t)at[2] * PBWC__GRID + (size_t)at[1]) * PBWC__GRID + at[0];
}

/* The copy of a point at x. */
static void pbwc__copy_at(const pbwc__period *period, size_t i, const double shift[3], double *x)
{
    const size_t dim = (size_t)period->dim;
    const double *p = period->x.at + i * dim;
    size_t k;
    for (k = 0; k < dim; k++) {
        x[k] = !period->is_lattice ? p[k] + shift[k] * period->size[k]
             : p[k] + (shift[0] * period->vector[0][k] + shift[1] * period->vector[1][k]
                       + shift[2] * period->vector[2][k]);
    }
}

/* The shifts of point i between from and to. */
static void pbwc__shift_range(const pbwc__period *period, size_t i, double first[3], double last[3])
{
    const double *p = period->x.at + i * (size_t)period->dim;
    int k;
    for (k = 0; k < 3; k++) {
        first[k] = last[k] = 0;
        if (k < period->dim && (period->axes >> k & 1) != 0) {
            const double h = pbwc__height(period, k, p);
            first[k] = ceil((period->from[k] - h) / period->size[k]);
            last[k] = floor((period->to[k] - h) / period->size[k]);
        }
    }
}

/* Returns whether the copy of point i at x is in the padded box or at a mark. */
static int pbwc__is_copied(const pbwc__period *period, size_t i, const double *x)
{
    int at[3] = { 0, 0, 0 }, k, inside = 1;
    int nearby = period->thin.at != NULL && period->thin.at[i] != 0;
    for (k = 0; k < period->dim; k++) {
        const double h = pbwc__height(period, k, x);
        at[k] = pbwc__grid_at(period, k, h);
        if ((period->axes >> k & 1) != 0) {
            inside &= h >= -period->margin[k] && h <= period->size[k] + period->margin[k];
            nearby &= h >= -0.5 * period->size[k] && h <= 1.5 * period->size[k];
        }
    }
    return inside || nearby || *pbwc__grid_mark(period, at) != 0;
}

static int pbwc__compare_copies(const void *left, const void *right)
{
    const pbwc__copy *a = (const pbwc__copy *)left, *b = (const pbwc__copy *)right;
    return pbwc__compare(a->shift, b->shift, 3, a->source, b->source);
}

/* Returns whether the mesh of this round has a copy; x: where that is. */
static int pbwc__is_present(const pbwc__period *period, const pbwc__copy *copy, const double *x)
{
    double first[3], last[3];
    int k, within = 1;
    pbwc__shift_range(period, copy->source, first, last);
    for (k = 0; k < 3; k++) {
        within &= copy->shift[k] >= first[k] && copy->shift[k] <= last[k];
    }
    return (within && pbwc__is_copied(period, copy->source, x))
        || (period->searched.added.count > 0
            && bsearch(copy, period->searched.added.at, period->searched.added.count, sizeof *copy,
                       pbwc__compare_copies) != NULL);
}

/* A ball of which the deepest missing copy is searched. */
typedef struct pbwc__ball {
    const pbwc__period *period;
    const double *x;                       /* its centre */
    double along[3];                       /* that in the frame */
    double limit;                          /* the squared radius, less the depth of the deepest copy so far */
    double square;                         /* the squared radius */
    pbwc__copy copy;                       /* with the shift at hand */
    pbwc__found *found;
} pbwc__ball;

/* Tries all points with one shift. */
static void pbwc__search_points(pbwc__ball *ball)
{
    const pbwc__period *period = ball->period;
    const pbwc__searched *tree = &period->searched;
    const size_t dim = (size_t)period->dim;
    size_t stack[PBWC__TREE_LEVELS * PBWC__BRANCHES], depth = 1, k, i;
    double moved[3] = { 0, 0, 0 };
    pbwc__copy_at(period, 0, ball->copy.shift, moved);
    for (k = 0; k < dim; k++) {                      /* the centre, seen from the points */
        moved[k] = ball->x[k] - (moved[k] - period->x.at[k]);
    }
    for (stack[0] = tree->level[tree->levels - 1]; depth > 0; ) {
        const size_t node = stack[--depth];
        const double *box = tree->boxes.at + 6 * node;
        double square = 0;
        size_t level = 0, first, end;
        for (k = 0; k < dim; k++) {
            const double off = moved[k] < box[k] ? box[k] - moved[k]
                             : moved[k] > box[3 + k] ? moved[k] - box[3 + k] : 0;
            square += off * off;
        }
        if (square >= ball->limit) {
            continue;
        }
        while (node >= tree->level[level + 1]) {
            level++;
        }
        first = (node - tree->level[level]) * PBWC__BRANCHES;
        end = level == 0 ? period->count : tree->level[level] - tree->level[level - 1];
        end = first + PBWC__BRANCHES < end ? first + PBWC__BRANCHES : end;
        for (i = first; level > 0 && i < end; i++) {
            stack[depth++] = tree->level[level - 1] + i;
        }
        for (i = first; level == 0 && i < end; i++) {
            double p[3];
            ball->copy.source = tree->order.at[i];
            pbwc__copy_at(period, ball->copy.source, ball->copy.shift, p);
            square = period->heaviest - period->w.at[ball->copy.source];
            for (k = 0; k < dim; k++) {
                square += (p[k] - ball->x[k]) * (p[k] - ball->x[k]);
            }
            if (square < ball->limit && !pbwc__is_present(period, &ball->copy, p)) {
                ball->limit = square;
                ball->found->copy = ball->copy;
                ball->found->depth = ball->square - square;
            }
        }
    }
}

/* Tries the shifts along axes of the frame up to the k-th one, nearest first; sum: of those along the others, where
   the points are `far` from the centre, squared. */
static void pbwc__search_shifts(pbwc__ball *ball, int k, const double sum[3], double away)
{
    const pbwc__period *period = ball->period;
    const pbwc__searched *tree = &period->searched;
    const int axis = k < 0 ? 0 : tree->axis[k];
    double middle = 0, next[3] = { 0, 0, 0 };
    int side, i;
    if (k < 0) {
        if (fabs(ball->copy.shift[0]) + fabs(ball->copy.shift[1]) + fabs(ball->copy.shift[2]) > 0) {
            pbwc__search_points(ball);
        }
        return;
    }
    if ((period->axes >> axis & 1) != 0) {
        middle = floor((ball->along[k] - sum[k] - 0.5 * (tree->low[k] + tree->high[k])) / tree->step[axis][k] + 0.5);
    }
    for (side = 1; side >= -1; side -= 2) {
        double shift = side > 0 ? middle : middle - 1;
        for (; (period->axes >> axis & 1) != 0 || (side > 0 && !(fabs(shift) > 0)); shift += side) {
            const double at = ball->along[k] - sum[k] - shift * tree->step[axis][k];
            const double off = at < tree->low[k] ? tree->low[k] - at : at > tree->high[k] ? at - tree->high[k] : 0;
            if (away + off * off >= ball->limit) {
                break;
            }
            for (i = 0; i < k; i++) {
                next[i] = sum[i] + shift * tree->step[axis][i];
            }
            ball->copy.shift[axis] = shift;
            pbwc__search_shifts(ball, k - 1, next, away + off * off);
        }
    }
    ball->copy.shift[axis] = 0;
}

/* Searches the ball around x for missing copies; found: the deepest one in the balls of a cell or simplex. */
static void pbwc__search(pbwc__period *period, const double *x, double radius, pbwc__found *found)
{
    const double none[3] = { 0, 0, 0 };
    const pbwc__searched *tree = &period->searched;
    pbwc__ball ball;
    int k, i;
    memset(&ball, 0, sizeof ball);
    ball.period = period;
    ball.x = x;
    ball.square = radius * radius;
    ball.limit = ball.square - (found->copy.source != PBW_NONE ? found->depth : 0);
    ball.found = found;
    for (k = 0; k < period->dim; k++) {
        for (i = 0; i < period->dim; i++) {
            ball.along[k] += tree->frame[k][i] * x[i];
        }
    }
    pbwc__search_shifts(&ball, period->dim - 1, none, 0);
    if (found->copy.source != PBW_NONE) {
        PBW_ATOMIC_STORE(&period->marked, 1);
    }
}

/* If the ball around x leaves the padded box, marks what it covers, or searches it; square: of its radius, less the
   largest weight; which: the point, or the number of points and a simplex, that has the ball. */
static void pbwc__certify(pbwc__period *period, const double *x, double square, size_t which)
{
    const double radius = sqrt(square + period->heaviest > 0 ? square + period->heaviest : 0) * (1 + 1e-9);
    int from[3] = { 0, 0, 0 }, to[3] = { 0, 0, 0 }, at[3], k, inside = 1;
    double widest = 0;
    for (k = 0; k < period->dim; k++) {
        const double slack = radius + 1e-12 * (period->high[k] - period->low[k]), h = pbwc__height(period, k, x);
        widest = slack > widest ? slack : widest;
        from[k] = pbwc__grid_at(period, k, h - slack);
        to[k] = pbwc__grid_at(period, k, h + slack);
        if ((period->axes >> k & 1) != 0) {
            inside &= h - slack > -period->margin[k] && h + slack < period->size[k] + period->margin[k];
        }
    }
    if (period->searched.on) {
        if (!inside) {
            pbwc__search(period, x, widest, period->searched.found.at + which);
        }
        return;
    }
    for (at[2] = from[2]; !inside && at[2] <= to[2]; at[2]++) {
        for (at[1] = from[1]; at[1] <= to[1]; at[1]++) {
            for (at[0] = from[0]; at[0] <= to[0]; at[0]++) {
                unsigned char *mark = pbwc__grid_mark(period, at);
                if (PBW_ATOMIC_LOAD(mark) == 0) {         /* threads may write the same */
                    PBW_ATOMIC_STORE(mark, 1);
                    PBW_ATOMIC_STORE(&period->marked, 1);
                }
            }
        }
    }
}

/* The balls of a cut cell. */
static void pbwc__certify_cut(const pbwc__work *work, pbw_index v)
{
    const pbw_mesh *mesh = work->job->mesh;
    const pbwc__poly *poly = &work->cutter.poly;
    const size_t dim = (size_t)mesh->dim;
    size_t i, k;
    for (i = 0; i < poly->loop.count; i++) {
        const double *d = poly->x.at[poly->loop.at[i]];
        double x[3], square = mesh->weights != NULL ? -mesh->weights[v] : 0;
        for (k = 0; k < dim; k++) {
            x[k] = mesh->points[v * dim + k] + d[k];
            square += d[k] * d[k];
        }
        pbwc__certify(work->job->period, x, square, v);
    }
}

/* The balls of the simplices at cells that are not cut. */
static pbw_status pbwc__certify_simplices(void *arg, size_t from, size_t to)
{
    const pbwc__job *job = (const pbwc__job *)arg;
    const pbw_mesh *mesh = job->mesh;
    const size_t dim = (size_t)mesh->dim;
    size_t k;
    for (; from < to; from++) {
        const pbw_index *corner = mesh->simplices + from * (dim + 1);
        double x[3], square = mesh->weights != NULL ? -mesh->weights[corner[0]] : 0;
        int read = 0;
        for (k = 0; k <= dim; k++) {
            read |= corner[k] < job->count && job->cut.at[corner[k]] == 0;
        }
        if (read) {
            (void)pbwc__centre_of(mesh, dim, (pbw_index)from, x);
            for (k = 0; k < dim; k++) {
                square += x[k] * x[k];
                x[k] += mesh->points[corner[0] * dim + k];
            }
            pbwc__certify(job->period, x, square, job->count + from);
        }
    }
    return PBW_OK;
}

/* ------------------------------------------------------------------------------------------------------
   >>ranges       Ranges of points, each with memory of its own; then their parts in one.
   In: stars and polytopes, range by range.  Out: the caller's arrays.
   Holds: the arrays do not depend on which thread has which range.
   ------------------------------------------------------------------------------------------------------ */
/* Returns whether the star's polytope can be cut: all centres are good, and none is so far from the domain that the
   cuts lose digits. */
static int pbwc__is_near(const pbwc__work *work)
{
    size_t i, k;
    int nearby = (work->flags & PBWC__GOOD) != 0;
    for (i = 0; i < work->cutter.poly.x.count; i++) {
        for (k = 0; k < (size_t)work->job->mesh->dim; k++) {
            nearby &= fabs(work->cutter.poly.x.at[i][k]) < 4 * work->job->extent[k];
        }
    }
    return nearby;
}

/* The polytope of a cell that the domain cuts.  Returns 0 if there is no memory. */
static int pbwc__cut_out(pbwc__work *work, pbw_index v)
{
    if (work->job->mesh->dim == 2 && work->links.count == 0 && !pbwc__add_sides(work)) {
        return 0;
    }
    if (!work->open && !pbwc__star_poly(work)) {
        return 0;
    }
    return work->open || !pbwc__is_near(work) ? pbwc__cut_cell(work, v) : pbwc__cut_star(work, v);
}

/* The cell of v, if there is no polygon.  Returns 0 if there is no memory. */
static int pbwc__cell(pbwc__work *work, pbw_index v)
{
    pbwc__job *job = work->job;
    const int facets = (job->what & PBW_CELLS_FACETS) != 0;
    const int whole = job->parts.at != NULL && (job->states.at[v] & PBWC__LEFT) == 0;    /* its volume is known */
    double sum[4] = { 0, 0, 0, 0 };
    size_t k;
    if (whole && (job->what & (PBW_CELLS_SHAPES | PBW_CELLS_MERGE)) == 0) {
        pbwc__start_star(work, v);
        return pbwc__gather_simplices(work) && pbwc__star_facets(work);
    }
    if (!pbwc__gather_some(work, v, facets)) {
        return 0;
    }
    if (whole || pbwc__star_volume(work)) {
        return !facets || pbwc__star_facets(work);
    }
    if (!pbwc__cut_out(work, v)) {
        return 0;
    }
    for (k = 0; k < work->cutter.poly.start.count; k++) {
        (void)pbwc__sum_facet(&work->cutter.poly, k, job->mesh->dim, sum);
    }
    pbwc__set_cell(job, v, sum);
    if (job->period != NULL) {
        job->cut.at[v] = 1;
        pbwc__certify_cut(work, v);
    }
    if (facets && job->merged.at != NULL && !pbwc__cut_exactly(work)) {
        return 0;
    }
    if (!(sum[3] > 0) || work->cutter.poly.start.count == 0) {       /* the domain at most touches the cell */
        memset(sum, 0, sizeof sum);
        pbwc__set_cell(job, v, sum);
        return 1;
    }
    return !facets || pbwc__cut_facets(work, v);
}

/* Ends the cells of shared vertices, and lists those left for their stars, near ones together.  Returns 0 if there is
   no memory. */
static int pbwc__add_totals(pbwc__job *job, size_t chunks, pbwc__indices *left)
{
    unsigned char *flags = job->states.at;
    size_t c, i, k;
    for (c = 0; c < chunks; c++) {
        const pbwc__totals *kept = &job->ranges.at[c].totals;
        for (i = 0; i < kept->count; i++) {
            const pbwc__total *total = kept->at + i;
            const size_t v = total->vertex;
            const int more = (flags[v] & PBWC__ADDED) != 0;
            flags[v] |= (unsigned char)(total->flags | PBWC__ADDED);
            job->volumes[v] = total->sum[3] + (more ? job->volumes[v] : 0);
            for (k = 0; k < 3; k++) {
                job->centroids[3 * v + k] = total->sum[k] + (more ? job->centroids[3 * v + k] : 0);
            }
        }
    }
    for (c = 0; c < chunks; c++) {
        const pbwc__totals *kept = &job->ranges.at[c].totals;
        for (i = 0; i < kept->count; i++) {
            const size_t v = kept->at[i].vertex;
            if ((flags[v] & (PBWC__LISTED | PBWC__LEFT)) == PBWC__LEFT) {
                if (!PBW_PUSH(&job->memory, *left, (pbw_index)v)) {
                    return 0;
                }
            } else if ((flags[v] & PBWC__LISTED) == 0) {
                double sum[4];
                memcpy(sum, job->centroids + 3 * v, 3 * sizeof *sum);
                sum[3] = job->volumes[v];
                pbwc__set_cell(job, (pbw_index)v, sum);
            }
            flags[v] |= PBWC__LISTED;
        }
    }
    return 1;
}

/* Cells from the list of those that are left. */
static pbw_status pbwc__left_cells(void *arg, size_t from, size_t to)
{
    pbwc__job *job = (pbwc__job *)arg;
    pbwc__work work;
    int good = pbwc__work_start(&work, job);
    size_t i;
    for (i = from; good && i < to; i++) {
        good = pbwc__cell(&work, job->left.at[i]);
    }
    pbwc__work_end(&work);
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* All cells in space; those that are left only if no facets are wanted.  Returns a status. */
static pbw_status pbwc__add_all(pbwc__job *job, size_t chunks)
{
    const pbw_options *options = &job->options;
    const size_t simplices = job->mesh->simplex_count;
    const int facets = (job->what & PBW_CELLS_FACETS) != 0;
    pbw_status status = PBW_OK;
    if (facets && !PBW_FIT(&job->memory, job->parts, 6 * simplices + 1)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbw_for(options, simplices, PBWC__CHUNK, pbwc__add_chunk, job);
    if (status == PBW_OK) {
        status = PBW_ZEROS(&job->memory, job->states, job->count) && pbwc__add_totals(job, chunks, &job->left)
               ? PBW_OK : PBW_ERROR_MEMORY;
    }
    return status != PBW_OK || facets ? status
         : pbw_for(options, job->left.count, PBWC__LEFTS, pbwc__left_cells, job);
}

/* The cell of v, with the counts of its facets and entries.  Returns a status. */
static pbw_status pbwc__count_cell(pbwc__work *work, pbw_index v)
{
    pbwc__job *job = work->job;
    pbwc__range *out = work->out;
    const size_t facets = out->neighbors.count, entries = out->loops.count;
    const pbw_status status = job->clip != NULL ? pbwc__clip_cell(work, v)
                            : pbwc__cell(work, v) ? PBW_OK : PBW_ERROR_MEMORY;
    job->first[v + 1] = out->neighbors.count - facets;
    if ((job->what & PBW_CELLS_SHAPES) != 0) {
        job->entries.at[v + 1] = out->loops.count - entries;
    }
    return status == PBW_OK && !PBW_PUSH(work->memory, out->cells, v) ? PBW_ERROR_MEMORY : status;
}

/* Makes the cells of the points with their incident simplex in the range: these are close together, however points
   are numbered. */
static pbw_status pbwc__cells_range(void *arg, size_t from, size_t to)
{
    pbwc__job *job = (pbwc__job *)arg;
    const size_t corners = (size_t)job->mesh->dim + 1;
    pbwc__work work;
    size_t i, k;
    pbw_status status = pbwc__work_start(&work, job) ? PBW_OK : PBW_ERROR_MEMORY;
    work.out = job->ranges.at + from / PBWC__CHUNK;
    for (i = from; status == PBW_OK && i < to; i++) {
        if (job->vertices != NULL) {                 /* its centre, which is kept or soon needed */
            const double origin[3] = { 0, 0, 0 };
            (void)pbwc__from_site(job, work.centres.at, corners - 1, origin, (pbw_index)i,
                                  job->vertices + i * (corners - 1));
        }
        for (k = 0; k < corners; k++) {
            const pbw_index v = job->mesh->simplices[i * corners + k];
            if (job->mesh->incident[v] == i && v < job->count && status == PBW_OK) {
                status = pbwc__count_cell(&work, v);
            }
        }
    }
    pbwc__work_end(&work);
    return status;
}

/* Where a range's items begin in the arrays of all. */
typedef struct pbwc__joining {
    pbwc__job *job;
    size_t *vertices, *rays;               /* per range */
    pbw_index *neighbors, *loops;
    double *areas, *all_vertices, *all_rays;
    size_t *loop_first;
} pbwc__joining;

/* Copies the loops of a cell, the range's entries from `at` on, into the result. */
static void pbwc__join_loops(const pbwc__joining *joining, size_t r, pbw_index v, size_t facet, size_t at)
{
    const pbwc__job *job = joining->job;
    const pbwc__range *range = job->ranges.at + r;
    const size_t dim = (size_t)job->mesh->dim, simplices = job->mesh->simplex_count;
    const pbw_index *counts = range->loop_counts.at, *from = range->loops.at;
    const pbw_index vertices = (pbw_index)(joining->vertices[r] / dim - simplices);
    const pbw_index rays = (pbw_index)(joining->rays[r] / dim);
    const pbw_index ray = PBW_NONE - (pbw_index)(range->rays.count / dim);
    const size_t begin = job->entries.at[v], end = job->entries.at[v + 1];
    size_t i, entry = begin;
    for (i = job->first[v]; i < job->first[v + 1]; i++) {
        joining->loop_first[i] = entry;
        entry += counts[facet++];
    }
    for (i = begin; i < end; i++) {
        const pbw_index corner = from[at++];
        joining->loops[i] = corner < simplices ? corner : corner >= ray ? corner - rays : corner + vertices;
    }
}

static pbw_status pbwc__join(void *arg, size_t from, size_t to)
{
    const pbwc__joining *joining = (const pbwc__joining *)arg;
    const pbwc__job *job = joining->job;
    size_t r, i;
    for (r = from; r < to; r++) {
        const pbwc__range *range = job->ranges.at + r;
        size_t facet = 0, entry = 0;
        for (i = 0; i < range->cells.count; i++) {
            const pbw_index v = range->cells.at[i];
            const size_t first = job->first[v], count = job->first[v + 1] - first;
            if (count > 0) {
                memcpy(joining->neighbors + first, range->neighbors.at + facet,
                       count * sizeof(pbw_index));
                memcpy(joining->areas + first, range->areas.at + facet, count * sizeof(double));
            }
            if (joining->loops != NULL) {
                const size_t *entries = job->entries.at + v;
                pbwc__join_loops(joining, r, v, facet, entry);
                entry += entries[1] - entries[0];
            }
            facet += count;
        }
        if (range->vertices.count > 0) {
            memcpy(joining->all_vertices + joining->vertices[r], range->vertices.at,
                   range->vertices.count * sizeof(double));
        }
        if (range->rays.count > 0) {
            memcpy(joining->all_rays + joining->rays[r], range->rays.at, range->rays.count * sizeof(double));
        }
    }
    return PBW_OK;
}

/* What pbw_cells.memory points at. */
typedef struct pbwc__owned {
    pbw_memory memory;
    pbwc__doubles volumes, centroids, sites, areas, vertices, rays;
    pbwc__sizes first, loop_first;
    pbwc__indices neighbors, loops;
    PBW_ARRAY(signed char) shifts;
} pbwc__owned;

static void pbwc__drop(pbw_memory *memory, pbw_cells *cells)
{
    pbwc__owned *own = (pbwc__owned *)cells->memory;
    PBW_RELEASE(memory, own->volumes);
    PBW_RELEASE(memory, own->centroids);
    PBW_RELEASE(memory, own->sites);
    PBW_RELEASE(memory, own->areas);
    PBW_RELEASE(memory, own->vertices);
    PBW_RELEASE(memory, own->rays);
    PBW_RELEASE(memory, own->first);
    PBW_RELEASE(memory, own->loop_first);
    PBW_RELEASE(memory, own->neighbors);
    PBW_RELEASE(memory, own->loops);
    PBW_RELEASE(memory, own->shifts);
    (void)pbw_memory_resize(memory, own, 1, 0, sizeof *own);
    memset(cells, 0, sizeof *cells);
}

PBWDEF void pbw_cells_free(pbw_cells *cells)
{
    if (cells != NULL && cells->memory != NULL) {
        pbw_memory memory = ((pbwc__owned *)cells->memory)->memory;
        pbwc__drop(&memory, cells);
    }
}

static void pbwc__sum_ranges(pbwc__joining *joining, size_t ranges, size_t *sums)
{
    const pbwc__job *job = joining->job;
    size_t r;
    sums[0] = sums[1] = sums[3] = 0;
    sums[2] = (job->what & PBW_CELLS_SHAPES) != 0 ? job->mesh->simplex_count * (size_t)job->mesh->dim : 0;
    for (r = 0; r < ranges; r++) {
        const pbwc__range *range = job->ranges.at + r;
        joining->vertices[r] = sums[2];
        joining->rays[r] = sums[3];
        sums[0] += range->neighbors.count;
        sums[1] += range->loops.count;
        sums[2] += range->vertices.count;
        sums[3] += range->rays.count;
    }
}

/* Facets and shapes of all ranges, one after the other. */
static pbw_status pbwc__join_all(pbwc__job *job, size_t ranges)
{
    const size_t dim = (size_t)job->mesh->dim;
    const int shapes = (job->what & PBW_CELLS_SHAPES) != 0;
    pbw_cells *cells = job->cells;
    pbwc__owned *own = (pbwc__owned *)cells->memory;
    pbw_memory *memory = &job->memory;
    pbwc__sizes begins;
    pbwc__joining joining;
    size_t sums[4], v;
    pbw_status status = PBW_OK;
    memset(&begins, 0, sizeof begins);
    memset(&joining, 0, sizeof joining);
    if (!PBW_FIT(memory, begins, 2 * ranges + 1)) {
        return PBW_ERROR_MEMORY;
    }
    joining.job = job;
    joining.vertices = begins.at;
    joining.rays = joining.vertices + ranges;
    pbwc__sum_ranges(&joining, ranges, sums);
    if (!PBW_FIT(memory, own->neighbors, sums[0] + 1) || !PBW_FIT(memory, own->areas, sums[0] + 1)
        || (shapes
            && (!PBW_FIT(memory, own->loop_first, sums[0] + 1) || !PBW_FIT(memory, own->loops, sums[1] + 1)
                || !PBW_FIT(memory, own->vertices, sums[2] + 1) || !PBW_FIT(memory, own->rays, sums[3] + 1)))) {
        status = PBW_ERROR_MEMORY;
    } else if (sums[2] / dim + sums[3] / dim >= PBW_NONE) {
        status = PBW_ERROR_TOO_LARGE;
    }
    cells->neighbors = joining.neighbors = own->neighbors.at;
    cells->areas = joining.areas = own->areas.at;
    cells->loop_first = joining.loop_first = own->loop_first.at;
    cells->loops = joining.loops = own->loops.at;
    cells->vertices = joining.all_vertices = own->vertices.at;
    cells->rays = joining.all_rays = own->rays.at;
    if (status == PBW_OK && shapes) {
        joining.loop_first[sums[0]] = sums[1];
    }
    for (v = 0; v < cells->cell_count; v++) {
        job->first[v + 1] += job->first[v];
        if (shapes) {
            job->entries.at[v + 1] += job->entries.at[v];
        }
    }
    if (status == PBW_OK) {
        status = pbw_for(&job->options, ranges, 1, pbwc__join, &joining);
    }
    cells->facet_count = sums[0];
    cells->vertex_count = sums[2] / dim;
    cells->ray_count = sums[3] / dim;
    PBW_RELEASE(memory, begins);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>merging      Centres that coincide.
   Two simplices that share a facet have one centre if and only if the far corner of either lies exactly on the
   sphere of the other.
   In: a mesh.  Out: merged[s] is the first simplex that is connected to s by such facets.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwc__ties { const pbw_mesh *mesh; unsigned char *tied; } pbwc__ties;     /* a bit per corner */

static int pbwc__is_tied(const pbw_mesh *mesh, size_t simplex, size_t facet)
{
    const size_t dim = (size_t)mesh->dim, corners = dim + 1;
    const pbw_index *v = mesh->simplices + simplex * corners;
    const size_t beyond = mesh->neighbors[simplex * corners + facet];
    const double *x[5] = { NULL, NULL, NULL, NULL, NULL };
    double w[5];
    size_t i, j = 0;
    while (mesh->neighbors[beyond * corners + j] != simplex) {
        j++;
    }
    for (i = 0; i <= corners; i++) {
        const size_t p = i < corners ? v[i] : mesh->simplices[beyond * corners + j];
        x[i] = mesh->points + p * dim;
        w[i] = mesh->weights != NULL ? mesh->weights[p] : 0;
    }
    return (dim == 2 ? pbw_power2(x[0], x[1], x[2], x[3], w) : pbw_power3(x[0], x[1], x[2], x[3], x[4], w)) == 0;
}

static pbw_status pbwc__find_ties(void *arg, size_t from, size_t to)
{
    const pbwc__ties *ties = (const pbwc__ties *)arg;
    const size_t corners = (size_t)ties->mesh->dim + 1;
    size_t i;
    for (; from < to; from++) {
        unsigned char bits = 0;
        for (i = 0; i < corners; i++) {
            const pbw_index beyond = ties->mesh->neighbors[from * corners + i];
            if (beyond != PBW_NONE && beyond > from && pbwc__is_tied(ties->mesh, from, i)) {
                bits = (unsigned char)(bits | 1u << i);
            }
        }
        ties->tied[from] = bits;
    }
    return PBW_OK;
}

static pbw_status pbwc__merge(pbwc__job *job)
{
    const pbw_mesh *mesh = job->mesh;
    const size_t count = mesh->simplex_count, corners = (size_t)mesh->dim + 1;
    pbwc__bytes tied;
    pbwc__ties ties;
    pbw_index *merged;
    size_t s, i;
    pbw_status status;
    memset(&tied, 0, sizeof tied);
    if (!PBW_FIT(&job->memory, job->merged, count + 1) || !PBW_FIT(&job->memory, tied, count + 1)) {
        PBW_RELEASE(&job->memory, tied);
        return PBW_ERROR_MEMORY;
    }
    ties.mesh = mesh;
    ties.tied = tied.at;
    status = pbw_for(&job->options, count, 4096, pbwc__find_ties, &ties);
    merged = job->merged.at;
    for (s = 0; s < count; s++) {
        merged[s] = (pbw_index)s;
    }
    for (s = 0; s < count && status == PBW_OK; s++) {
        for (i = 0; i < corners; i++) {
            if ((ties.tied[s] >> i & 1) != 0) {
                const pbw_index a = pbwc__root(merged, (pbw_index)s);
                const pbw_index b = pbwc__root(merged, mesh->neighbors[s * corners + i]);
                merged[a > b ? a : b] = a > b ? b : a;
            }
        }
    }
    for (s = 0; s < count; s++) {
        merged[s] = pbwc__root(merged, (pbw_index)s);
    }
    PBW_RELEASE(&job->memory, tied);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>domain       The domain as a polytope and as planes.
   In: the caller's box, planes, rings.  Out: those of the job; what bounds nothing is refused.
   ------------------------------------------------------------------------------------------------------ */
/* The box cut by all planes.  Returns PBW_ERROR_ARGUMENT if nothing is left. */
static pbw_status pbwc__cut_domain(pbwc__job *job, const pbw_domain *domain, const double *low, const double *high)
{
    const size_t dim = (size_t)job->mesh->dim;
    pbwc__cutter cutter;
    size_t i;
    int good;
    memset(&cutter, 0, sizeof cutter);
    good = pbwc__poly_box(&job->memory, &cutter.poly, (int)dim, low, high);
    for (i = 0; good && i < domain->plane_count; i++) {
        good = pbwc__cut(&job->memory, &cutter, (int)dim, domain->planes + i * (dim + 1),
                         (pbw_index)(PBW_NONE - 1 - 2 * dim - i));
    }
    pbwc__poly_release(&job->memory, &job->domain);
    job->domain = cutter.poly;
    memset(&cutter.poly, 0, sizeof cutter.poly);
    pbwc__cutter_release(&job->memory, &cutter);
    return !good ? PBW_ERROR_MEMORY : job->domain.loop.count == 0 ? PBW_ERROR_ARGUMENT : PBW_OK;
}

/* The bounds of the domain's corners that are in a loop.  Returns 1 if a wall of the box is left. */
static int pbwc__bounds(const pbwc__job *job, double *low, double *high)
{
    const size_t dim = (size_t)job->mesh->dim;
    size_t i, k;
    int walls = 0;
    for (i = 0; i < job->domain.loop.count; i++) {
        const double *x = job->domain.x.at[job->domain.loop.at[i]];
        for (k = 0; k < dim; k++) {
            low[k] = i == 0 || x[k] < low[k] ? x[k] : low[k];
            high[k] = i == 0 || x[k] > high[k] ? x[k] : high[k];
        }
    }
    for (i = 0; i < job->domain.name.count; i++) {
        walls |= job->domain.name.at[i] > PBW_NONE - 1 - 2 * dim;
    }
    return walls;
}

/* Makes a domain of planes alone: cuts it from a box so large that a remaining wall means an unbounded domain, then
   again from a box that fits, which gives the most exact corners. */
static pbw_status pbwc__bound_planes(pbwc__job *job, const pbw_domain *domain, double *low, double *high)
{
    const size_t dim = (size_t)job->mesh->dim;
    double size = 0;
    size_t i, k;
    pbw_status status;
    for (i = 0; i < domain->plane_count; i++) {
        const double *plane = domain->planes + i * (dim + 1);
        double normal = 0;
        for (k = 0; k < dim; k++) {
            normal += fabs(plane[k]);
        }
        size = normal > 0 && fabs(plane[dim]) / normal > size ? fabs(plane[dim]) / normal : size;
    }
    for (k = 0; k < dim; k++) {
        low[k] = -1e6 * (size > 0 ? size : 1);
        high[k] = -low[k];
    }
    status = pbwc__cut_domain(job, domain, low, high);
    if (status == PBW_OK && pbwc__bounds(job, low, high)) {
        status = PBW_ERROR_ARGUMENT;
    }
    for (k = 0; k < dim; k++) {
        const double margin = 0.01 * (high[k] - low[k]);
        low[k] -= margin;
        high[k] += margin;
    }
    return status;
}

static pbw_status pbwc__prepare_domain(pbwc__job *job, const pbw_domain *domain)
{
    const size_t dim = (size_t)job->mesh->dim;
    double low[3], high[3], longest = 0;
    size_t i, k;
    pbw_status status = PBW_OK;
    for (k = 0; k < 3; k++) {
        job->low[k] = -HUGE_VAL;
        job->high[k] = HUGE_VAL;
    }
    if (domain != NULL && domain->ring_count > 0) {
        job->bounded = 1;
        status = pbwc__check_polygon(job->mesh, domain);
        return status == PBW_OK && job->mesh->point_count > 0 ? pbwc__copy_rings(job, domain) : status;
    }
    if (domain == NULL || (domain->box == NULL && domain->plane_count == 0)) {
        return PBW_OK;
    }
    job->bounded = 1;
    for (k = 0; k < dim && domain->box != NULL; k++) {
        low[k] = domain->box[k];
        high[k] = domain->box[dim + k];
        if (job->period == NULL || (job->period->axes >> k & 1) == 0) {
            job->low[k] = low[k];
            job->high[k] = high[k];
        }
        job->slack[k] = 1e-14 * (fabs(low[k]) + fabs(high[k]));
        if (!(low[k] < high[k]) || !(high[k] - low[k] < HUGE_VAL)) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    job->planes = domain->planes;
    job->plane_count = domain->plane_count;
    for (i = 0; i < domain->plane_count; i++) {
        const double *plane = domain->planes + i * (dim + 1);
        double normal = 0;
        for (k = 0; k < dim; k++) {
            normal += fabs(plane[k]);
        }
        if (!(normal > 0) || !(normal < HUGE_VAL) || !(fabs(plane[dim]) < HUGE_VAL)) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    if (domain->box == NULL) {
        status = pbwc__bound_planes(job, domain, low, high);
    }
    for (k = 0; k < dim; k++) {
        job->from[k] = low[k];
        job->to[k] = high[k];
        job->extent[k] = high[k] - low[k];
        longest = job->extent[k] > longest ? job->extent[k] : longest;
    }
    (void)frexp(longest, &job->exponent);
    return status == PBW_OK ? pbwc__cut_domain(job, domain, low, high) : status;
}

/* ------------------------------------------------------------------------------------------------------
   >>flat         Points that span no simplex: one, or all on a line or in a plane.
   In: those.  Out: a mesh of them and the corners of a large simplex.
   The cells of the corners do not meet the domain, so in there all other cells stay as they are: all that is in the
   box around domain and points is nearer to each point than to the corners, which have the least weight.
   ------------------------------------------------------------------------------------------------------ */
/* Corner i of a simplex around a box, further from all in it than its points from each other. */
static void pbwc__apex(int dim, int i, const double *low, const double *high, double *x)
{
    double far_out = 0;
    int k;
    for (k = 0; k < dim; k++) {
        far_out += 8 * (high[k] - low[k]);
    }
    for (k = 0; k < dim; k++) {
        x[k] = low[k] + (i == dim ? -far_out : i == k ? far_out : 0);
    }
}

/* The box around the domain and all points. */
static void pbwc__surround(const pbwc__job *job, double *low, double *high)
{
    const size_t dim = (size_t)job->mesh->dim, count = job->mesh->point_count * dim;
    const size_t corners = job->clip != NULL ? job->clip->count * dim : dim;   /* else the low corner */
    size_t i, k;
    for (k = 0; k < dim; k++) {
        low[k] = high[k] = job->mesh->points[k];
        for (i = k; i < count + corners; i += dim) {
            const double x = i < count ? job->mesh->points[i]
                           : job->clip != NULL ? job->clip->x.at[i - count] : job->from[k];
            low[k] = x < low[k] ? x : low[k];
            high[k] = x > high[k] ? x : high[k];
        }
        if (job->clip == NULL) {
            high[k] = job->to[k] > high[k] ? job->to[k] : high[k];
        }
    }
}

/* Makes a mesh of the points and the corners of a large simplex.  The domain is prepared. */
static pbw_status pbwc__span(pbwc__job *job)
{
    const pbw_mesh *mesh = job->mesh;
    const size_t dim = (size_t)mesh->dim, count = mesh->point_count, total = count + dim + 1;
    double low[3], high[3], least = 0;
    pbwc__doubles x, w;
    size_t i;
    pbw_status status = PBW_ERROR_MEMORY;
    memset(&x, 0, sizeof x);
    memset(&w, 0, sizeof w);
    if (PBW_FIT(&job->memory, x, total * dim) && PBW_FIT(&job->memory, w, total)) {
        pbwc__surround(job, low, high);
        memcpy(x.at, mesh->points, count * dim * sizeof(double));
        for (i = 0; i < count; i++) {
            w.at[i] = pbwc__weight(mesh, (pbw_index)i);
            least = i == 0 || w.at[i] < least ? w.at[i] : least;
        }
        for (i = 0; i <= dim; i++) {
            pbwc__apex((int)dim, (int)i, low, high, x.at + (count + i) * dim);
            w.at[count + i] = least;
        }
        status = pbw_triangulate((int)dim, x.at, mesh->weights != NULL ? w.at : NULL, total,
                                 &job->options, &job->spanned);
    }
    PBW_RELEASE(&job->memory, x);
    PBW_RELEASE(&job->memory, w);
    job->mesh = status == PBW_OK ? &job->spanned : mesh;
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>calls        The calls without periods.
   In: a mesh, a domain.  Out: cells, or a status, and nothing held.
   ------------------------------------------------------------------------------------------------------ */
/* Empty cells, for points that are no vertices. */
static pbw_status pbwc__no_cells(void *arg, size_t from, size_t to)
{
    pbwc__job *job = (pbwc__job *)arg;
    const size_t dim = (size_t)job->mesh->dim;
    memset(job->volumes + from, 0, (to - from) * sizeof(double));
    memcpy(job->centroids + from * dim, job->mesh->points + from * dim, (to - from) * dim * sizeof(double));
    memset(job->first + from + 1, 0, (to - from) * sizeof(size_t));
    if (job->entries.at != NULL) {
        memset(job->entries.at + from + 1, 0, (to - from) * sizeof(size_t));
    }
    if (job->cut.at != NULL) {
        memset(job->cut.at + from, 0, to - from);
    }
    return PBW_OK;
}

/* The arrays of all cells, empty.  Returns a status. */
static pbw_status pbwc__start_cells(pbwc__job *job, size_t ranges)
{
    const size_t count = job->cells->cell_count, dim = (size_t)job->mesh->dim;
    const int shapes = (job->what & PBW_CELLS_SHAPES) != 0;
    pbwc__owned *own = (pbwc__owned *)job->cells->memory;
    pbw_memory *memory = &job->memory;
    if (!PBW_FIT(memory, own->volumes, count + 1) || !PBW_FIT(memory, own->centroids, count * dim + 1)
        || !PBW_FIT(memory, own->first, count + 1) || !PBW_ZEROS(memory, job->ranges, ranges)
        || (shapes && (!PBW_FIT(memory, own->vertices, job->mesh->simplex_count * dim + 1)
                       || !PBW_FIT(memory, job->entries, count + 1)))
        || (job->period != NULL && !PBW_FIT(memory, job->cut, count + 1))) {
        return PBW_ERROR_MEMORY;
    }
    job->cells->volumes = job->volumes = own->volumes.at;
    job->cells->centroids = job->centroids = own->centroids.at;
    job->cells->first = job->first = own->first.at;
    job->vertices = own->vertices.at;
    job->first[0] = 0;
    if (job->entries.at != NULL) {
        job->entries.at[0] = 0;
    }
    return pbw_for(&job->options, count, PBWC__CHUNK, pbwc__no_cells, job);
}

static void pbwc__release_ranges(pbwc__job *job)
{
    size_t r;
    for (r = 0; r < job->ranges.count; r++) {
        pbwc__range *range = job->ranges.at + r;
        PBW_RELEASE(&job->memory, range->cells);
        PBW_RELEASE(&job->memory, range->totals);
        PBW_RELEASE(&job->memory, range->neighbors);
        PBW_RELEASE(&job->memory, range->areas);
        PBW_RELEASE(&job->memory, range->loop_counts);
        PBW_RELEASE(&job->memory, range->loops);
        PBW_RELEASE(&job->memory, range->vertices);
        PBW_RELEASE(&job->memory, range->rays);
    }
    PBW_RELEASE(&job->memory, job->ranges);
}

static pbw_status pbwc__compute(pbwc__job *job, const pbw_domain *domain)
{
    size_t simplices, ranges;
    pbw_status status = pbwc__prepare_domain(job, domain);
    if (status == PBW_OK && job->bounded && job->mesh->simplex_count == 0 && job->count > 0) {
        status = pbwc__span(job);
    }
    simplices = job->mesh->simplex_count;
    ranges = (simplices + PBWC__CHUNK - 1) / PBWC__CHUNK;
    status = status == PBW_OK ? pbwc__start_cells(job, ranges) : status;
    if (status == PBW_OK && (job->what & PBW_CELLS_MERGE) != 0) {
        status = pbwc__merge(job);
    }
    if (status == PBW_OK && job->clip != NULL && simplices > 0) {
        status = pbwc__start_clip(job);
    }
    if (status == PBW_OK && job->mesh->dim == 3) {
        status = pbwc__add_all(job, ranges);
    }
    if (status == PBW_OK && (job->mesh->dim == 2 || (job->what & PBW_CELLS_FACETS) != 0)) {
        status = pbw_for(&job->options, simplices, PBWC__CHUNK, pbwc__cells_range, job);
    }
    if (status == PBW_OK && job->period != NULL) {
        status = pbw_for(&job->options, simplices, PBWC__CHUNK, pbwc__certify_simplices, job);
    }
    if (status == PBW_OK && (job->what & PBW_CELLS_FACETS) != 0) {
        status = pbwc__join_all(job, ranges);
    }
    pbwc__release_ranges(job);
    return status;
}

static int pbwc__is_valid(unsigned what)
{
    return (what & ~(PBW_CELLS_FACETS | PBW_CELLS_SHAPES | PBW_CELLS_MERGE)) == 0;
}

/* job: stays where it is until all that calls with job->options made is freed. */
static void pbwc__job_start(pbwc__job *job, unsigned what, const pbw_options *options)
{
    memset(job, 0, sizeof *job);
    job->what = what | ((what & PBW_CELLS_SHAPES) != 0 ? PBW_CELLS_FACETS : 0);
    if (options != NULL) {
        job->options = *options;
    }
    pbw_memory_start(&job->memory, options);
    job->options.stride = job->options.weight_stride = 0;
    job->options.flags = 0;
    job->options.trace = NULL;
    pbw_memory_nest(&job->memory, &job->options);
}

/* Fills job->cells, with the mesh, the count, what and the memory of the job.  Leaves them empty if it fails. */
static pbw_status pbwc__run(pbwc__job *job, const pbw_domain *domain)
{
    pbw_cells *cells = job->cells;
    pbwc__owned *own = (pbwc__owned *)pbw_memory_resize(&job->memory, NULL, 0, 1, sizeof *own);
    pbw_status status;
    if (own == NULL) {
        return PBW_ERROR_MEMORY;
    }
    memset(own, 0, sizeof *own);
    cells->dim = job->mesh->dim;
    cells->cell_count = job->count;
    cells->memory = own;
    status = pbwc__compute(job, domain);
    if (status == PBW_OK && (job->what & PBW_CELLS_FACETS) == 0) {
        PBW_RELEASE(&job->memory, own->first);
        cells->first = NULL;
    }
    pbwc__poly_release(&job->memory, &job->domain);
    PBW_RELEASE(&job->memory, job->merged);
    PBW_RELEASE(&job->memory, job->entries);
    PBW_RELEASE(&job->memory, job->cut);
    PBW_RELEASE(&job->memory, job->states);
    PBW_RELEASE(&job->memory, job->left);
    PBW_RELEASE(&job->memory, job->parts);
    if (job->clip != NULL) {
        pbwc__end_clip(job);
    }
    own->memory = job->memory;
    if (status != PBW_OK) {
        pbwc__drop(&job->memory, job->cells);
    }
    return status;
}

PBWDEF pbw_status pbw_cells_of(const pbw_mesh *mesh, const pbw_domain *domain, unsigned what,
                               const pbw_options *options, pbw_cells *cells)
{
    pbwc__job job;
    pbwc__clip clip;
    pbw_status status;
    if (cells == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(cells, 0, sizeof *cells);
    memset(&clip, 0, sizeof clip);
    if (mesh == NULL || (mesh->dim != 2 && mesh->dim != 3) || (mesh->simplex_count > 0 && mesh->neighbors == NULL)
        || !pbwc__is_valid(what)
        || (domain != NULL && (domain->periodic != 0 || domain->lattice != NULL
                                || (domain->plane_count > 0 && domain->planes == NULL)))) {
        return PBW_ERROR_ARGUMENT;
    }
    pbwc__job_start(&job, what, options);
    job.mesh = mesh;
    job.count = mesh->point_count;
    job.cells = cells;
    job.clip = domain != NULL && domain->ring_count > 0 ? &clip : NULL;
    status = pbwc__run(&job, domain);
    status = status == PBW_OK && job.mesh->simplex_count == 0 ? PBW_DEGENERATE : status;
    pbw_free(&job.spanned);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>units        Units of periodic boxes and lattices, points in them, how far cells reach.
   In: the domain and the points.  Out: those, rounded and moved in; sizes, walls, margins.
   ------------------------------------------------------------------------------------------------------ */
/* Moves x into the parallelepiped. */
static void pbwc__move_in(const pbwc__period *period, double *x)
{
    const size_t dim = (size_t)period->dim;
    double count[3];
    size_t i, k;
    for (i = 0; i < dim; i++) {
        count[i] = floor(pbwc__height(period, (int)i, x) / period->size[i]);
    }
    for (i = 0; i < dim; i++) {
        for (k = 0; k < dim; k++) {
            x[k] -= count[i] * period->vector[i][k];
        }
    }
}

/* A point of a lattice in its units: moved in, as far as doubles go, rounded, then moved exactly. */
static void pbwc__snap_to_lattice(const pbwc__period *period, double *x)
{
    size_t k;
    pbwc__move_in(period, x);
    for (k = 0; k < (size_t)period->dim; k++) {
        x[k] = floor(x[k] / period->unit[k] + 0.5) * period->unit[k];
    }
    pbwc__move_in(period, x);
}

/* Sizes and points in the units, in [0, size) along periodic axes. */
static pbw_status pbwc__snap(pbwc__period *period, const double *points, const double *weights, const double *box)
{
    const size_t dim = (size_t)period->dim;
    double *x = period->x.at, *w = period->w.at;
    size_t i, k;
    for (i = 0; i < period->count * dim; i++) {
        k = i % dim;
        x[i] = points[i] + 0.0;
        if (!(fabs(x[i]) < HUGE_VAL)) {
            return PBW_ERROR_NOT_FINITE;
        }
        if (period->is_lattice) {
            if (k + 1 == dim) {
                pbwc__snap_to_lattice(period, x + i - k);
            }
            continue;
        }
        if ((period->axes >> k & 1) != 0) {
            x[i] = fmod(floor((x[i] - box[k]) / period->unit[k] + 0.5) * period->unit[k], period->size[k]);
            x[i] += x[i] < 0 ? period->size[k] : 0;
        }
        period->low[k] = x[i] < period->low[k] ? x[i] : period->low[k];
        period->high[k] = x[i] > period->high[k] ? x[i] : period->high[k];
    }
    for (i = 0; weights != NULL && i < period->count; i++) {
        w[i] = weights[i];
        if (!(fabs(w[i]) < HUGE_VAL)) {
            return PBW_ERROR_NOT_FINITE;
        }
        period->heaviest = i == 0 || w[i] > period->heaviest ? w[i] : period->heaviest;
        period->lightest = i == 0 || w[i] < period->lightest ? w[i] : period->lightest;
    }
    return PBW_OK;
}

/* Copies fill so much around the box at first. */
static void pbwc__set_margins(pbwc__period *period, double volume)
{
    const double each = volume / (double)(period->count > 0 ? period->count : 1);
    const double spacing = pow(each, 1.0 / (double)period->dim);
    int k;
    for (k = 0; k < period->dim; k++) {
        period->margin[k] = 3.2 * spacing < period->size[k] ? 3.2 * spacing : period->size[k];
    }
}

/* Replaces vectors of a lattice by sums and differences that are shorter, by pairs (Lagrange) and by all, until there
   are none: in three dimensions, too, these are the shortest (Minkowski; Semaev 2001). */
static void pbwc__reduce(pbwc__period *period)
{
    const int dim = period->dim;
    int i, k, t, again = 1, rounds;
    for (rounds = 0; again && rounds < 10000; rounds++) {
        again = 0;
        for (i = 0; i < dim; i++) {
            for (t = 0; t < (dim == 3 ? 4 : 1); t++) {       /* one of the others, or their sum or difference */
                const int p = (i + 1) % dim, q = (i + dim - 1) % dim;
                const double a = t == 1 ? 0 : 1, b = dim == 2 || t == 0 ? 0 : t == 3 ? -1 : 1;
                double by[3] = { 0, 0, 0 }, sums[3] = { 0, 0, 0 }, dot = 0, square = 0, before = 0, after = 0, m;
                for (k = 0; k < dim; k++) {
                    by[k] = a * period->vector[p][k] + b * period->vector[q][k];
                    sums[k] = a * period->to_given[p][k] + b * period->to_given[q][k];
                    dot += by[k] * period->vector[i][k];
                    square += by[k] * by[k];
                }
                m = square > 0 ? floor(dot / square + 0.5) : 0;
                for (k = 0; k < dim; k++) {
                    const double less = period->vector[i][k] - m * by[k];
                    before += period->vector[i][k] * period->vector[i][k];
                    after += less * less;
                }
                for (k = 0; k < dim && after < before * (1 - 1e-12); k++) {
                    period->vector[i][k] -= m * by[k];
                    period->to_given[i][k] -= m * sums[k];
                    again = 1;
                }
            }
        }
    }
}

/* The walls of a lattice: half as much again as its own cell reaches along the axes.  That is cut from the box of
   walls that are there by the bisectors of nearby points, with or without some that only touch it. */
static pbw_status pbwc__bound_cell(pbwc__period *period)
{
    const int dim = period->dim;
    double low[3], high[3], bound[3] = { 0, 0, 0 };
    pbwc__cutter cutter;
    int shift[3], i, k, good;
    size_t l;
    memset(&cutter, 0, sizeof cutter);
    for (k = 0; k < dim; k++) {
        high[k] = period->wall[k];
        low[k] = -high[k];
    }
    good = pbwc__poly_box(period->memory, &cutter.poly, dim, low, high);
    for (i = 0; i < (dim == 3 ? 27 : 9) && good; i++) {
        double plane[4] = { 0, 0, 0, 0 }, square = 0;
        shift[0] = i % 3 - 1;
        shift[1] = i / 3 % 3 - 1;
        shift[2] = dim == 3 ? i / 9 - 1 : 0;
        for (k = 0; k < dim; k++) {
            plane[k] = shift[0] * period->vector[0][k] + shift[1] * period->vector[1][k]
                     + shift[2] * period->vector[2][k];
            square += plane[k] * plane[k];
        }
        plane[dim] = square / 2;
        good = !(square > 0) || pbwc__cut(period->memory, &cutter, dim, plane, 0);
    }
    for (l = 0; l < cutter.poly.loop.count && good; l++) {
        for (k = 0; k < dim; k++) {
            bound[k] = fmax(bound[k], fabs(cutter.poly.x.at[cutter.poly.loop.at[l]][k]));
        }
    }
    for (k = 0; k < dim; k++) {
        period->wall[k] = 1.5 * bound[k];
    }
    pbwc__cutter_release(period->memory, &cutter);
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Normals, heights and units of a lattice, of which the vectors are then multiples. */
static pbw_status pbwc__make_lattice(pbwc__period *period, const double *lattice)
{
    const int dim = period->dim;
    double longest = 0, all = 0, product = 1, volume = 0, g[3][3];
    int i, k, exponent;
    for (i = 0; i < dim; i++) {
        memcpy(period->vector[i], lattice + i * dim, (size_t)dim * sizeof(double));
        period->to_given[i][i] = 1;
        for (k = 0; k < dim; k++) {
            if (!(fabs(period->vector[i][k]) < 1e150)) {
                return PBW_ERROR_ARGUMENT;
            }
        }
    }
    pbwc__reduce(period);
    for (i = 0; i < dim; i++) {
        const double *v = period->vector[i];
        const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        longest = length > longest ? length : longest;
        all += length;
        product *= length;
    }
    if (!(longest > 1e-150)) {
        return PBW_ERROR_ARGUMENT;
    }
    (void)frexp(longest, &exponent);
    for (i = 0; i < dim; i++) {
        period->unit[i] = ldexp(1, exponent - 45);
        period->wall[i] = 0.75 * all;
    }
    for (i = 0; i < dim; i++) {
        for (k = 0; k < dim; k++) {
            period->vector[i][k] = floor(period->vector[i][k] / period->unit[k] + 0.5) * period->unit[k];
        }
    }
    memset(g, 0, sizeof g);
    for (i = 0; i < dim; i++) {                      /* perpendicular to all vectors but one */
        const double *p = period->vector[(i + 1) % dim], *q = period->vector[(i + 2) % dim];
        if (dim == 3) {
            pbwc__cross(p, q, g[i]);
        } else {
            g[i][0] = p[1];
            g[i][1] = -p[0];
        }
    }
    for (i = 0; i < dim; i++) {
        const double size = sqrt(g[i][0] * g[i][0] + g[i][1] * g[i][1] + g[i][2] * g[i][2]);
        const double *v = period->vector[i], det = v[0] * g[i][0] + v[1] * g[i][1] + v[2] * g[i][2];
        if (!(fabs(det) > 1e-6 * product) || !(size > 0)) {
            return PBW_ERROR_ARGUMENT;
        }
        for (k = 0; k < 3; k++) {
            period->normal[i][k] = (det > 0 ? g[i][k] : -g[i][k]) / size;
        }
        period->size[i] = fabs(det) / size;
        period->high[i] = period->size[i];
        volume = fabs(det);
    }
    pbwc__set_margins(period, volume);
    return pbwc__bound_cell(period);
}

/* Units so fine that all copies within reach are exact: 2^-51 of the box, coarser in very long boxes. */
static pbw_status pbwc__units(pbwc__period *period, const double *box)
{
    const size_t dim = (size_t)period->dim;
    double longest = 0, volume = 1;
    size_t k;
    for (k = 0; k < dim; k++) {
        period->size[k] = box[dim + k] - box[k];
        if (!(period->size[k] > 1e-150) || !(period->size[k] < 1e150)) {
            return PBW_ERROR_ARGUMENT;
        }
        longest = period->size[k] > longest ? period->size[k] : longest;
        volume *= period->size[k];
        period->low[k] = (period->axes >> k & 1) != 0 ? 0 : box[k];
        period->high[k] = (period->axes >> k & 1) != 0 ? period->size[k] : box[dim + k];
    }
    for (k = 0; k < dim; k++) {
        double reach = longest / period->size[k];
        int exponent;
        (void)frexp(period->size[k], &exponent);
        for (exponent -= 51; reach > 1; reach /= 2) {
            exponent++;
        }
        period->unit[k] = ldexp(1, exponent + 3);
        period->size[k] = floor(period->size[k] / period->unit[k] + 0.5) * period->unit[k];
        period->wall[k] = 0.75 * period->size[k];
    }
    pbwc__set_margins(period, volume);
    return PBW_OK;
}

/* Where balls of cells can reach, and the grid, finer where most of them are. */
static pbw_status pbwc__reach(pbwc__period *period)
{
    double square = period->heaviest - period->lightest, radius;
    int i, k;
    for (k = 0; k < period->dim; k++) {
        const double half = period->is_lattice ? period->wall[k]
                          : (period->high[k] - period->low[k]) * ((period->axes >> k & 1) != 0 ? 0.75 : 1);
        square += half * half;
    }
    radius = 1.001 * sqrt(square);
    for (k = 0; k < period->dim; k++) {
        if ((period->axes >> k & 1) != 0) {          /* from the site to a corner, and the ball there */
            double away = radius + (period->is_lattice ? 0 : period->wall[k]);
            for (i = 0; i < period->dim && period->is_lattice; i++) {
                away += 1.001 * fabs(period->normal[k][i]) * period->wall[i];
            }
            period->low[k] = -away;
            period->high[k] = period->size[k] + away;
        }
        period->grid[k] = (period->axes >> k & 1) != 0 ? -0.6 * period->size[k] : period->low[k];
        period->step[k] = ((period->axes >> k & 1) != 0 ? 2.2 * period->size[k] : period->high[k] - period->low[k])
                          / PBWC__GRID;
    }
    for (k = 0; k < period->dim; k++) {
        double most = 0;
        for (i = 0; i < period->dim && period->is_lattice; i++) {
            most += period->high[i] / period->size[i] * fabs(period->vector[i][k]);
        }
        period->reach[k] = period->is_lattice ? most : period->high[k];
        if ((period->axes >> k & 1) != 0 && period->reach[k] > 4e15 * period->unit[k]) {
            return PBW_ERROR_ARGUMENT;               /* copies would not be exact */
        }
    }
    return PBW_ZEROS(period->memory, period->marks, (size_t)PBWC__GRID * PBWC__GRID * PBWC__GRID) ? PBW_OK
           : PBW_ERROR_MEMORY;
}

/* ------------------------------------------------------------------------------------------------------
   >>rounds       Copies and rounds of periodic boxes and lattices.
   In: points in the units.  Out: cells, by meshes of points and copies until no copy is missing.
   ------------------------------------------------------------------------------------------------------ */
/* Where copies may be: the padded box and all marks. */
static void pbwc__extent(pbwc__period *period)
{
    int at[3], k;
    for (k = 0; k < period->dim; k++) {
        const double half = period->thin.at != NULL ? 0.5 * period->size[k] : 0;
        period->from[k] = half > period->margin[k] ? -half : -period->margin[k];
        period->to[k] = period->size[k] - period->from[k];
    }
    for (at[2] = 0; at[2] < PBWC__GRID; at[2]++) {
        for (at[1] = 0; at[1] < PBWC__GRID; at[1]++) {
            for (at[0] = 0; at[0] < PBWC__GRID; at[0]++) {
                for (k = 0; *pbwc__grid_mark(period, at) != 0 && k < period->dim; k++) {
                    const double low = at[k] == 0 ? period->low[k]
                                     : period->grid[k] + period->step[k] * (at[k] - 0.01);
                    const double high = at[k] == PBWC__GRID - 1 ? period->high[k]
                                      : period->grid[k] + period->step[k] * (at[k] + 1.01);
                    period->from[k] = low < period->from[k] ? low : period->from[k];
                    period->to[k] = high > period->to[k] ? high : period->to[k];
                }
            }
        }
    }
}

/* One more point.  Returns 0 if there is no memory. */
static int pbwc__add_copy(pbwc__period *period, const double *x, double weight, pbw_index source)
{
    const size_t dim = (size_t)period->dim;
    period->x.count = period->total * dim;
    period->w.count = period->total;
    if (!PBW_RESERVE(period->memory, period->x, dim) || !PBW_PUSH(period->memory, period->w, weight)
        || !PBW_PUSH(period->memory, period->source, source)) {
        return 0;
    }
    memcpy(period->x.at + period->x.count, x, dim * sizeof(double));
    period->total++;
    return 1;
}

static int pbwc__add_copies(pbwc__period *period, size_t i)
{
    const double weight = period->w.at[i];
    double x[3], first[3], last[3], shift[3];
    pbwc__shift_range(period, i, first, last);
    for (shift[2] = first[2]; shift[2] <= last[2]; shift[2]++) {
        for (shift[1] = first[1]; shift[1] <= last[1]; shift[1]++) {
            for (shift[0] = first[0]; shift[0] <= last[0]; shift[0]++) {
                if (shift[0] == 0 && shift[1] == 0 && shift[2] == 0) {
                    continue;
                }
                pbwc__copy_at(period, i, shift, x);
                if (pbwc__is_copied(period, i, x) && !pbwc__add_copy(period, x, weight, (pbw_index)i)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Lists all points with their copies, and the apexes of a simplex so large that their cells do not meet the grid. */
static pbw_status pbwc__copies(pbwc__period *period)
{
    double x[3], low[3];
    size_t i, k;
    period->total = period->count;
    period->source.count = 0;
    pbwc__extent(period);
    for (i = 0; i < period->count; i++) {
        if (period->total >= PBW_NONE - 16) {
            return PBW_ERROR_TOO_LARGE;
        }
        if (!pbwc__add_copies(period, i)) {
            return PBW_ERROR_MEMORY;
        }
    }
    for (i = 0; i < period->searched.added.count; i++) {
        const pbwc__copy *copy = period->searched.added.at + i;
        pbwc__copy_at(period, copy->source, copy->shift, x);
        if (!pbwc__add_copy(period, x, period->w.at[copy->source], copy->source)) {
            return PBW_ERROR_MEMORY;
        }
    }
    for (i = 0; period->apexes && i <= (size_t)period->dim; i++) {
        for (k = 0; k < 3; k++) {
            low[k] = period->is_lattice ? -period->reach[k] : period->low[k];
        }
        pbwc__apex(period->dim, (int)i, low, period->reach, x);
        if (!pbwc__add_copy(period, x, period->lightest, 0)) {
            return PBW_ERROR_MEMORY;
        }
    }
    return PBW_OK;
}

/* Chooses the first point in each cell of a grid over the box, if these are at most a share of its cells, and forgets
   all marks. */
static pbw_status pbwc__choose_thin(pbwc__period *period, double share)
{
    const size_t dim = (size_t)period->dim;
    const double least = pow((double)period->count / 8, 1.0 / (double)dim), most = dim == 3 ? 16 : 64;
    const size_t side = (size_t)(least < most ? least : most);
    unsigned char *thin;
    pbwc__bytes taken;
    size_t i, k, chosen = 0;
    memset(&taken, 0, sizeof taken);
    if (!PBW_ZEROS(period->memory, taken, side * side * (dim == 3 ? side : 1))
        || !PBW_FIT(period->memory, period->thin, period->count)) {
        PBW_RELEASE(period->memory, taken);
        return PBW_ERROR_MEMORY;
    }
    thin = period->thin.at;
    for (i = 0; i < period->count; i++) {
        unsigned char *slot = taken.at;
        size_t at = 0;
        for (k = 0; k < dim; k++) {
            const double low = (period->axes >> k & 1) != 0 ? 0 : period->low[k];
            const double high = (period->axes >> k & 1) != 0 ? period->size[k] : period->high[k];
            const double h = pbwc__height(period, (int)k, period->x.at + i * dim);
            const double cell = (h - low) / (high - low) * (double)side;
            at = at * side + (!(cell > 0) ? 0 : cell >= (double)side ? side - 1 : (size_t)cell);
        }
        thin[i] = slot[at] == 0;
        chosen += slot[at] == 0;
        slot[at] = 1;
    }
    if ((double)chosen > share * (double)taken.count) {
        PBW_RELEASE(period->memory, period->thin);
    }
    memset(period->marks.at, 0, period->marks.count);
    PBW_RELEASE(period->memory, taken);
    return PBW_OK;
}

/* The given vectors of a lattice from a point to its copy.  Returns 0 if they are too many. */
static int pbwc__shifts_of(const pbwc__period *period, const double *copy, const double *point, signed char *shifts)
{
    const int dim = period->dim;
    double sum[3] = { 0, 0, 0 };
    int i, k;
    for (i = 0; i < dim; i++) {
        const double h = pbwc__height(period, i, copy) - pbwc__height(period, i, point);
        const double count = floor(h / period->size[i] + 0.5);
        for (k = 0; k < dim; k++) {
            sum[k] += count * period->to_given[i][k];
        }
    }
    for (k = 0; k < dim; k++) {
        if (!(fabs(sum[k]) <= 127)) {
            return 0;
        }
        shifts[k] = (signed char)sum[k];
    }
    return 1;
}

/* Replaces copies by their points and shifts, and moves all back to the caller's box. */
static pbw_status pbwc__unwrap(pbwc__job *job, const double *box)
{
    const pbwc__period *period = job->period;
    const size_t dim = (size_t)period->dim, facets = job->cells->facet_count;
    pbwc__owned *own = (pbwc__owned *)job->cells->memory;
    pbw_index *neighbors = own->neighbors.at;
    const double *x = period->x.at;
    size_t i, k;
    if (!PBW_FIT(&job->memory, own->sites, period->count * dim + 1)) {
        return PBW_ERROR_MEMORY;
    }
    job->cells->sites = own->sites.at;
    for (i = 0; i < period->count * dim; i++) {
        const double low = !period->is_lattice && (period->axes >> i % dim & 1) != 0 ? box[i % dim] : 0;
        job->centroids[i] += low;
        own->sites.at[i] = x[i] + low;
    }
    for (i = 0; i < job->cells->vertex_count * dim; i++) {
        own->vertices.at[i] += !period->is_lattice && (period->axes >> i % dim & 1) != 0 ? box[i % dim] : 0;
    }
    if ((job->what & PBW_CELLS_FACETS) != 0) {
        signed char *shifts;
        if (!PBW_ZEROS(&job->memory, own->shifts, facets * dim)) {
            return PBW_ERROR_MEMORY;
        }
        job->cells->shifts = shifts = own->shifts.at;
        for (i = 0; i < facets; i++) {
            const size_t copy = neighbors[i];
            if (copy >= period->count && copy < period->total) {
                neighbors[i] = period->source.at[copy - period->count];
                if (period->is_lattice
                    && !pbwc__shifts_of(period, x + copy * dim, x + neighbors[i] * dim, shifts + i * dim)) {
                    return PBW_ERROR_ARGUMENT;
                }
                for (k = 0; k < dim && !period->is_lattice; k++) {
                    const double shift = (x[copy * dim + k] - x[neighbors[i] * dim + k]) / period->size[k];
                    shifts[i * dim + k] = (signed char)((period->axes >> k & 1) == 0 ? 0 : shift);
                }
            }
        }
    }
    return PBW_OK;
}

/* Directions along which copies are searched, and where points and periods are along them (Gram-Schmidt). */
static void pbwc__set_frame(pbwc__period *period)
{
    pbwc__searched *tree = &period->searched;
    const int dim = period->dim;
    double vector[3][3] = { { 0 } }, square[3] = { 0, 0, 0 };
    size_t i;
    int k, m, c;
    for (k = 0; k < dim; k++) {
        for (m = 0; m < dim; m++) {
            vector[k][m] = period->is_lattice ? period->vector[k][m] : m == k ? period->size[k] : 0;
            square[k] += vector[k][m] * vector[k][m];
        }
        for (m = k; m > 0 && square[tree->axis[m - 1]] > square[k]; m--) {
            tree->axis[m] = tree->axis[m - 1];
        }
        tree->axis[m] = k;
    }
    for (k = 0; k < dim; k++) {
        double rest[3], length = 0;
        memcpy(rest, vector[tree->axis[k]], sizeof rest);
        for (m = 0; m < k; m++) {
            double along = 0;
            for (c = 0; c < dim; c++) {
                along += rest[c] * tree->frame[m][c];
            }
            for (c = 0; c < dim; c++) {
                rest[c] -= along * tree->frame[m][c];
            }
        }
        for (c = 0; c < dim; c++) {
            length += rest[c] * rest[c];
        }
        tree->low[k] = HUGE_VAL;
        tree->high[k] = -HUGE_VAL;
        for (c = 0; c < dim; c++) {
            tree->frame[k][c] = rest[c] / sqrt(length);
            for (m = 0; m < dim; m++) {
                tree->step[m][k] += tree->frame[k][c] * vector[m][c];
            }
        }
    }
    for (i = 0; i < period->count; i++) {
        for (k = 0; k < dim; k++) {
            double along = 0;
            for (c = 0; c < dim; c++) {
                along += tree->frame[k][c] * period->x.at[i * (size_t)dim + (size_t)c];
            }
            tree->low[k] = along < tree->low[k] ? along : tree->low[k];
            tree->high[k] = along > tree->high[k] ? along : tree->high[k];
        }
    }
}

/* Boxes around points, along a curve, and around boxes. */
static pbw_status pbwc__build_tree(pbwc__period *period, const pbw_options *options)
{
    pbwc__searched *tree = &period->searched;
    const size_t dim = (size_t)period->dim;
    size_t count = period->count, i, k, c, total = 0;
    pbw_status status;
    for (tree->levels = 0; tree->levels == 0 || count > 1; tree->levels++) {
        count = (count + PBWC__BRANCHES - 1) / PBWC__BRANCHES;
        tree->level[tree->levels] = total;
        total += count;
    }
    tree->level[tree->levels] = total;
    if (!PBW_FIT(period->memory, tree->order, period->count) || !PBW_FIT(period->memory, tree->boxes, total * 6)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbw_order(period->dim, period->x.at, period->count, options, tree->order.at);
    for (i = 0; status == PBW_OK && i < total; i++) {
        double *box = tree->boxes.at + 6 * i;
        for (k = 0; k < 3; k++) {
            box[k] = HUGE_VAL;
            box[3 + k] = -HUGE_VAL;
        }
    }
    for (i = 0; status == PBW_OK && i < period->count; i++) {
        const double *x = period->x.at + tree->order.at[i] * dim;
        for (c = 0, count = i; c < tree->levels; c++) {
            double *box = tree->boxes.at + 6 * (tree->level[c] + (count /= PBWC__BRANCHES));
            for (k = 0; k < dim; k++) {
                box[k] = x[k] < box[k] ? x[k] : box[k];
                box[3 + k] = x[k] > box[3 + k] ? x[k] : box[3 + k];
            }
        }
    }
    return status;
}

/* Returns whether the marked part is so many periods wide that trying all copies in it would take long.  In a cube it
   is 7 periods wide at most. */
static int pbwc__is_vast(const pbwc__period *period)
{
    double shifts = 1;
    int k;
    for (k = 0; k < period->dim; k++) {
        shifts *= (period->axes >> k & 1) != 0 ? (period->to[k] - period->from[k]) / period->size[k] + 1 : 1;
    }
    return shifts > pow(7, period->dim) && shifts * (double)period->count > 131072;
}

/* From now on searches balls for copies, one by one. */
static pbw_status pbwc__begin_searches(pbwc__period *period, const pbw_options *options)
{
    pbw_status status = PBW_OK;
    period->searched.on = 1;
    memset(period->marks.at, 0, period->marks.count);
    if (period->count >= 500 && period->thin.at == NULL) {
        status = pbwc__choose_thin(period, 1);
    }
    pbwc__set_frame(period);
    return status == PBW_OK ? pbwc__build_tree(period, options) : status;
}

/* Nothing is found yet in the balls of a mesh. */
static pbw_status pbwc__start_searches(pbwc__period *period, size_t simplices)
{
    pbwc__searched *searched = &period->searched;
    size_t i;
    if (!PBW_FIT(period->memory, searched->found, period->count + simplices)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < period->count + simplices; i++) {
        searched->found.at[i].copy.source = PBW_NONE;
    }
    searched->found.count = i;
    return PBW_OK;
}

/* Adds what searches found, each copy once.  Returns 0 if there is no memory. */
static int pbwc__add_found(pbwc__period *period)
{
    pbwc__searched *searched = &period->searched;
    pbwc__copy *copy;
    size_t i, kept = 0;
    for (i = 0; i < searched->found.count; i++) {
        const pbwc__copy *found = &searched->found.at[i].copy;
        if (found->source != PBW_NONE && !PBW_PUSH(period->memory, searched->added, *found)) {
            return 0;
        }
    }
    copy = searched->added.at;
    qsort(copy, searched->added.count, sizeof *copy, pbwc__compare_copies);
    for (i = 0; i < searched->added.count; i++) {
        if (i == 0 || pbwc__compare_copies(copy + i, copy + i - 1) != 0) {
            copy[kept++] = copy[i];
        }
    }
    searched->added.count = kept;
    return 1;
}

/* After a round, adds the copies that are marked or found.  Clears period->marked if all of them were there. */
static pbw_status pbwc__more_copies(pbwc__period *period, const pbw_options *options)
{
    const size_t before = period->total;
    pbw_status status;
    if (period->searched.on) {
        return pbwc__add_found(period) ? pbwc__copies(period) : PBW_ERROR_MEMORY;
    }
    pbwc__extent(period);
    if (pbwc__is_vast(period)) {
        status = pbwc__begin_searches(period, options);
        return status == PBW_OK ? pbwc__copies(period) : status;
    }
    status = pbwc__copies(period);
    if (status == PBW_OK && period->total == before) {
        period->marked = 0;
    } else if (status == PBW_OK && period->total > 5 * period->count && period->count >= 500
               && period->thin.at == NULL) {
        status = pbwc__choose_thin(period, 1);
        status = status == PBW_OK ? pbwc__copies(period) : status;
    }
    return status;
}

/* One round: the mesh of points and copies, and its cells; period->marked tells if more copies are needed. */
static pbw_status pbwc__round(pbwc__job *job, const double *box)
{
    pbwc__period *period = job->period;
    pbw_options own = job->options;
    pbw_domain domain;
    pbw_mesh mesh;
    double walls[6];
    const size_t dim = (size_t)period->dim;
    const double *weights = job->weighted ? period->w.at : NULL;
    size_t k;
    pbw_status status;
    memset(&domain, 0, sizeof domain);
    memset(&mesh, 0, sizeof mesh);
    own.flags = PBW_BORROW;
    status = pbw_triangulate(period->dim, period->x.at, weights, period->total, &own, &mesh);
    if (status == PBW_DEGENERATE && period->count > 0) {
        period->apexes = period->marked = 1;
        status = pbwc__copies(period);
    } else if (status == PBW_OK || status == PBW_DEGENERATE) {
        for (k = 0; k < dim; k++) {
            walls[k] = (period->axes >> k & 1) != 0 ? -period->wall[k] : box[k];
            walls[dim + k] = (period->axes >> k & 1) != 0 ? period->wall[k] : box[dim + k];
        }
        domain.box = walls;
        job->mesh = &mesh;
        status = period->searched.on ? pbwc__start_searches(period, mesh.simplex_count) : PBW_OK;
        status = status == PBW_OK ? pbwc__run(job, &domain) : status;
        if (status == PBW_OK && period->marked) {
            status = pbwc__more_copies(period, &job->options);
        }
        if (status == PBW_OK && !period->marked) {
            status = pbwc__unwrap(job, box);
        }
        if (job->cells->memory != NULL && (status != PBW_OK || period->marked)) {
            pbwc__drop(&job->memory, job->cells);
        }
    }
    pbw_free(&mesh);
    return status;
}

PBWDEF pbw_status pbw_cells_periodic(int dim, const double *points, const double *weights, size_t count,
                                     const pbw_domain *domain, unsigned what, const pbw_options *options,
                                     pbw_cells *cells)
{
    pbwc__period period;
    pbwc__job job;
    pbw_status status;
    if (cells == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(cells, 0, sizeof *cells);
    if ((dim != 2 && dim != 3) || (points == NULL && count > 0) || domain == NULL
        || (domain->box == NULL) == (domain->lattice == NULL)
        || domain->plane_count != 0 || domain->ring_count != 0 || (domain->periodic == 0) == (domain->box != NULL)
        || domain->periodic >> dim != 0 || !pbwc__is_valid(what)
        || (options != NULL && (options->stride != 0 || options->weight_stride != 0))) {
        return PBW_ERROR_ARGUMENT;
    }
    if (count >= PBW_NONE / 2) {
        return PBW_ERROR_TOO_LARGE;
    }
    memset(&period, 0, sizeof period);
    pbwc__job_start(&job, what, options);
    period.dim = dim;
    period.is_lattice = domain->lattice != NULL;
    period.axes = period.is_lattice ? (1u << dim) - 1 : domain->periodic;
    period.count = count;
    period.memory = &job.memory;
    job.period = &period;
    job.count = count;
    job.cells = cells;
    job.weighted = weights != NULL;
    status = PBW_FIT(&job.memory, period.x, count * (size_t)dim + 1) && PBW_ZEROS(&job.memory, period.w, count)
           ? PBW_OK : PBW_ERROR_MEMORY;
    if (status == PBW_OK) {
        status = period.is_lattice ? pbwc__make_lattice(&period, domain->lattice)
               : pbwc__units(&period, domain->box);
    }
    status = status == PBW_OK ? pbwc__snap(&period, points, weights, domain->box) : status;
    status = status == PBW_OK ? pbwc__reach(&period) : status;
    if (status == PBW_OK && count >= 500) {
        status = pbwc__choose_thin(&period, 0.3);
    }
    status = status == PBW_OK ? pbwc__copies(&period) : status;
    for (period.marked = 1; status == PBW_OK && period.marked; ) {
        period.marked = 0;
        status = pbwc__round(&job, domain->box);
    }
    PBW_RELEASE(&job.memory, period.x);
    PBW_RELEASE(&job.memory, period.w);
    PBW_RELEASE(&job.memory, period.source);
    PBW_RELEASE(&job.memory, period.marks);
    PBW_RELEASE(&job.memory, period.thin);
    PBW_RELEASE(&job.memory, period.searched.added);
    PBW_RELEASE(&job.memory, period.searched.found);
    PBW_RELEASE(&job.memory, period.searched.order);
    PBW_RELEASE(&job.memory, period.searched.boxes);
    if (cells->memory != NULL) {
        ((pbwc__owned *)cells->memory)->memory = job.memory;
    }
    return status;
}

PBW_CONTRACTION_ON
#endif /* PBW_CELLS_IMPLEMENTATION */
