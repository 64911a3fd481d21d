/* pbw_cells.h - v0.1.0 - cells of the Voronoi and of the power diagram - MIT-0

   QUICK START
   In one source file, define PBW_CELLS_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file.

       const double box[6] = { 0,0,0, 1,1,1 };                       // low corner, high corner
       pbw_domain domain = {0};
       pbw_cells cells = {0};
       domain.box = box;
       pbw_triangulate(3, points, NULL, count, NULL, &mesh);
       pbw_cells_of(&mesh, &domain, 0, NULL, &cells);                // of weighted points: power cells
       printf("%g\n", cells.volumes[7]);
       pbw_cells_free(&cells);

   HOW
   The cell of a vertex is the dual of its star: its corners are the centres of the star's simplices, its facets
   belong to the edges at the vertex.  Volumes and centroids come from one pass over the facets of the mesh: no cell
   is built.  Facets are read off the stars.  Cells with a corner outside the domain are cut: their polytope by the
   walls, or, at the hull, the domain by one half-space for each neighbour; only neighbours in the triangulation matter, as
   the cell is the intersection of their half-spaces.  All ways sum signed determinants relative to the site, so the
   order of the points, obtuse simplices and centres outside their simplex need no case.
   Cutting classifies each corner once, as inside or outside, and shares each new corner between its two facets:
   however the signs are rounded, the surface stays closed.

   PROMISES  (tests/test_cells.c guards them)
     same        the same bytes for any number of threads; volumes and centroids also whatever else a call computes
     whole       volumes in a domain add up to it, to 1e-12
     closed      areas times normals of a bounded cell add up to zero
     exact       with PBW_CELLS_MERGE, combinatorics are those of the true diagram, degenerate corners and all

   CONFIGURATION MACROS
     PBW_CELLS_IMPLEMENTATION    in one source file: compile the implementation there
     PBWCELLSDEF                 everywhere: your own linkage for the functions, for example static
*/
#ifndef PBW_CELLS_H
#define PBW_CELLS_H
#ifndef PBW_H
#include "pbw.h"
#endif

#ifndef PBWCELLSDEF
#define PBWCELLSDEF extern
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Where cells end.  All zero: nowhere, and cells at the hull are unbounded. */
typedef struct pbw_domain {
    const double *box;                     /* low corner, high corner: 2*dim numbers; NULL = none */
    const double *planes;                  /* half-spaces n.x <= c: dim numbers n, then c, each; NULL = none */
    size_t plane_count;
    unsigned periodic;                     /* pbw_cells_periodic: bit k = the box repeats along axis k */
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
    const size_t *first;                   /* cell_count + 1: the facets of cell i are first[i] .. first[i+1]-1 */
    const pbw_index *neighbors;            /* per facet: the point beyond; PBW_NONE - 1 - k: wall k of the domain,
                                              where 2*axis and 2*axis+1 are the box, low and high, and planes
                                              follow */
    const signed char *shifts;             /* pbw_cells_periodic: dim per facet: the neighbour is the point +
                                              shift * box size; else NULL */
    const double *areas;                   /* per facet: area, in the plane length; HUGE_VAL if unbounded */
    const double *vertices;                /* dim each; the first ones are the centres of the mesh's simplices */
    const size_t *loop_first;              /* facet_count + 1 */
    const pbw_index *loops;                /* corners of facet j: loop_first[j] .. loop_first[j+1]-1,
                                              counter-clockwise from outside the cell; in the plane two, and a
                                              cell's facets are in order.  PBW_NONE - 1 - k: at infinity, in direction k of rays */
    const double *rays;                    /* dim each: directions of length 1 */
    void *memory;                          /* private */
} pbw_cells;

/* Computes the cells of a mesh's points: Voronoi cells, with weights power cells; what: PBW_CELLS_* or'ed.
   domain: NULL = the whole space; else convex and bounded: a box, planes, or both.  Needs mesh->neighbors.
   A mesh of PBW_DEGENERATE points gives PBW_DEGENERATE and empty cells.  Fails as pbw_triangulate does, with
   PBW_ERROR_ARGUMENT also for a domain that is unbounded or empty, or periodic; cells is then left empty. */
PBWCELLSDEF pbw_status pbw_cells_of(const pbw_mesh *mesh, const pbw_domain *domain, unsigned what,
                                    const pbw_options *options, pbw_cells *cells);
/* The cells of points in a box that repeats along the axes of domain->periodic; along the others the box is a wall.
   First moves points into the box, and along periodic axes rounds coordinates and the box's size to multiples of some
   2^-48 of it (very long boxes: coarser), so that copies are exact translates.  Returns PBW_OK for any number of
   points from 1, and PBW_ERROR_ARGUMENT without a box, with planes, and where weights differ by so much that copies
   are not exact.  A point may be its own neighbour, or one point's twice, with different shifts. */
PBWCELLSDEF pbw_status pbw_cells_periodic(int dim, const double *points, const double *weights, size_t count,
                                          const pbw_domain *domain, unsigned what, const pbw_options *options,
                                          pbw_cells *cells);
PBWCELLSDEF void pbw_cells_free(pbw_cells *cells);           /* fine on {0}, fine twice */

#ifdef __cplusplus
}
#endif
#endif /* PBW_CELLS_H */

#if defined(PBW_CELLS_IMPLEMENTATION) && !defined(PBWCELLS__IMPLEMENTED)
#define PBWCELLS__IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(__GNUC__)
#define PBWC__ADD(x, y) __atomic_add_fetch(x, y, __ATOMIC_RELAXED)
#define PBWC__READ(x) __atomic_load_n(x, __ATOMIC_RELAXED)
#define PBWC__WRITE(x, y) __atomic_store_n(x, y, __ATOMIC_RELAXED)
#else
#define PBWC__READ(x) (*(x))
#define PBWC__WRITE(x, y) (*(x) = (y))
#define PBWC__ADD(x, y) (*(x) += (y))      /* such a pbw.h has one thread */
#endif

/* Compiled for each dimension, where the compiler can. */
#if defined(__GNUC__)
#define PBWC__INLINE inline __attribute__((always_inline))
#else
#define PBWC__INLINE
#endif

/* ------------------------------------------------------------------------------------------------------
   Memory: growing arrays through options.resize.
   Holds: used = the sum of all live arrays; over the limit nothing grows.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwc__memory {
    void *(*resize)(void *user, void *ptr, size_t old_size, size_t new_size);
    void *user;
    size_t limit, used;
} pbwc__memory;

typedef struct pbwc__array { void *data; size_t count, bytes; } pbwc__array;     /* count: the owner's */

static void *pbwc__default_resize(void *user, void *ptr, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) {
        free(ptr);
        return NULL;
    }
    return realloc(ptr, new_size);
}

static void pbwc__release(pbwc__memory *memory, pbwc__array *array)
{
    if (array->data != NULL) {
        (void)memory->resize(memory->user, array->data, array->bytes, 0);
        (void)PBWC__ADD(&memory->used, (size_t)0 - array->bytes);
    }
    memset(array, 0, sizeof *array);
}

/* Makes the array `bytes` long.  Returns 0 and leaves it alone if there is no memory. */
static int pbwc__resize(pbwc__memory *memory, pbwc__array *array, size_t bytes)
{
    void *data = NULL;
    const size_t used = PBWC__ADD(&memory->used, bytes - array->bytes);
    if (memory->limit == 0 || used <= memory->limit) {
        data = memory->resize(memory->user, array->data, array->bytes, bytes);
    }
    if (data == NULL) {
        (void)PBWC__ADD(&memory->used, array->bytes - bytes);
        return 0;
    }
    array->data = data;
    array->bytes = bytes;
    return 1;
}

/* Makes room for `extra` items after the last.  Returns the place of the first of them, or NULL. */
static void *pbwc__room(pbwc__memory *memory, pbwc__array *array, size_t extra, size_t size)
{
    const size_t need = (array->count + extra) * size, twice = 2 * array->bytes;
    if (need > array->bytes && !pbwc__resize(memory, array, need > twice ? need + 256 : twice)) {
        return NULL;
    }
    return (char *)array->data + array->count * size;
}

static int pbwc__push(pbwc__memory *memory, pbwc__array *array, pbw_index item)
{
    pbw_index *place = (pbw_index *)pbwc__room(memory, array, 1, sizeof item);
    if (place == NULL) {
        return 0;
    }
    *place = item;
    array->count++;
    return 1;
}
#define PBWC__INDICES(array) ((pbw_index *)(array).data)
#define PBWC__DOUBLES(array) ((double *)(array).data)

/* ------------------------------------------------------------------------------------------------------
   Centres: where the bisectors (with weights: radical planes) of a simplex meet, relative to its first corner a.
   With B, C, D the other corners relative to a and B2 = |B|^2 - (w_b - w_a), and so on,
       centre = (B2 CxD + C2 DxB + D2 BxC) / (2 B.CxD).
   The relative error is some 1e-15 L^3 / |B.CxD|, L the longest edge at a; below 1e-6 L^3 all is computed again in
   pairs of doubles, from exact differences, which leaves 1e-26 L^3 / |B.CxD|.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwc__dd { double high, low; } pbwc__dd;

static pbwc__dd pbwc__dd_sum(double a, double b)                     /* exact (Knuth 1969) */
{
    pbwc__dd s;
    double t;
    s.high = a + b;
    t = s.high - a;
    s.low = (a - (s.high - t)) + (b - t);
    return s;
}

static pbwc__dd pbwc__dd_add(pbwc__dd a, pbwc__dd b)
{
    pbwc__dd s = pbwc__dd_sum(a.high, b.high);
    return pbwc__dd_sum(s.high, s.low + (a.low + b.low));
}

static pbwc__dd pbwc__dd_times(pbwc__dd a, pbwc__dd b)
{
    const double p = a.high * b.high, e = fma(a.high, b.high, -p);
    return pbwc__dd_sum(p, e + (a.high * b.low + a.low * b.high));
}

static pbwc__dd pbwc__dd_minus(pbwc__dd a)
{
    a.high = -a.high;
    a.low = -a.low;
    return a;
}

static pbwc__dd pbwc__dd_minor(pbwc__dd a, pbwc__dd b, pbwc__dd c, pbwc__dd d)   /* a d - b c */
{
    return pbwc__dd_add(pbwc__dd_times(a, d), pbwc__dd_minus(pbwc__dd_times(b, c)));
}

/* row[i]: corner i + 1 relative to corner 0; height[i]: B2, C2, D2.  Returns 0 where pairs do not do: the simplex is
   flat to 14 digits. */
static int pbwc__centre_slow(int dim, const pbwc__dd row[3][3], const pbwc__dd *height, double least, double *centre)
{
    pbwc__dd sum[3], minor[3][3], det = { 0, 0 };
    int i, k;
    memset(sum, 0, sizeof sum);
    for (i = 0; i < dim; i++) {
        if (dim == 3) {                              /* the cross product of the other two rows */
            const pbwc__dd *p = row[(i + 1) % 3], *q = row[(i + 2) % 3];
            for (k = 0; k < 3; k++) {
                minor[i][k] = pbwc__dd_minor(p[(k + 1) % 3], p[(k + 2) % 3], q[(k + 1) % 3], q[(k + 2) % 3]);
            }
        } else {                                     /* the other row, turned */
            minor[i][0] = i == 0 ? row[1][1] : pbwc__dd_minus(row[0][1]);
            minor[i][1] = i == 0 ? pbwc__dd_minus(row[1][0]) : row[0][0];
        }
        for (k = 0; k < dim; k++) {
            sum[k] = pbwc__dd_add(sum[k], pbwc__dd_times(height[i], minor[i][k]));
        }
    }
    for (k = 0; k < dim; k++) {
        det = pbwc__dd_add(det, pbwc__dd_times(row[0][k], minor[0][k]));
    }
    for (k = 0; k < dim; k++) {                      /* positive, but perhaps below what pairs resolve */
        centre[k] = sum[k].high / (2 * (det.high > least ? det.high : least));
    }
    return det.high > 1e16 * least;
}

typedef struct pbwc__job pbwc__job;
typedef struct pbwc__period pbwc__period;
typedef struct pbwc__centre {
    pbw_index simplex;
    int good, inside;                      /* right to 12 digits; in the domain, for certain */
    double x[3];                           /* relative to the simplex's first corner */
} pbwc__centre;

static int pbwc__centre_exactly(const pbw_mesh *mesh, const pbw_index *corner, double least, double *centre)
{
    const size_t dim = (size_t)mesh->dim;
    const double *a = mesh->points + corner[0] * dim;
    pbwc__dd row[3][3], height[3];
    size_t i, k;
    memset(row, 0, sizeof row);
    for (i = 0; i < dim; i++) {
        const double *b = mesh->points + corner[i + 1] * dim;
        height[i].high = height[i].low = 0;
        if (mesh->weights != NULL) {
            height[i] = pbwc__dd_sum(mesh->weights[corner[0]], -mesh->weights[corner[i + 1]]);
        }
        for (k = 0; k < dim; k++) {
            row[i][k] = pbwc__dd_sum(b[k], -a[k]);
            height[i] = pbwc__dd_add(height[i], pbwc__dd_times(row[i][k], row[i][k]));
        }
    }
    return pbwc__centre_slow(mesh->dim, (const pbwc__dd (*)[3])row, height, least, centre);
}

/* Returns 0 if the centre may be far off. */
static int pbwc__centre_of(const pbw_mesh *mesh, pbw_index simplex, double *centre)
{
    const size_t dim = (size_t)mesh->dim;
    const pbw_index *corner = mesh->simplices + simplex * (dim + 1);
    const double *a = mesh->points + corner[0] * dim, *w = mesh->weights;
    double r[3][3], height[3], largest = 0, det, least;
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
        least = largest * 1e-30;
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
        least = largest * sqrt(largest) * 1e-30;
        if (det > 0 && det * det > 1e-12 * largest * largest * largest) {
            const double scale = 0.5 / det;
            for (k = 0; k < 3; k++) {
                centre[k] = (height[0] * m[0][k] + height[1] * m[1][k] + height[2] * m[2][k]) * scale;
            }
            return 1;
        }
    }
    return pbwc__centre_exactly(mesh, corner, least, centre);
}

/* ------------------------------------------------------------------------------------------------------
   Polytopes: corners, and facets as loops of corners, counter-clockwise from outside.  In the plane one loop, whose
   i-th edge, from corner i to the next, is facet i.
   Holds: each edge of a polytope in space is in two loops, once in each direction; so the surface is closed.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwc__poly {
    pbwc__array x;                         /* 3 doubles a corner (in the plane the last is 0); some in no loop */
    pbwc__array name, start, loop;         /* per facet: the neighbour or wall, where its loop starts; the loops */
} pbwc__poly;

typedef struct pbwc__cutter {
    pbwc__poly poly, next;
    pbwc__array side;                      /* per corner: distance beyond the plane, scaled */
    pbwc__array edges, cap;                /* cut edges: two corners and the new one; after each new one in the cap */
} pbwc__cutter;

static void pbwc__poly_clear(pbwc__poly *poly)
{
    poly->name.count = poly->start.count = poly->loop.count = 0;
}

static void pbwc__poly_release(pbwc__memory *memory, pbwc__poly *poly)
{
    pbwc__release(memory, &poly->x);
    pbwc__release(memory, &poly->name);
    pbwc__release(memory, &poly->start);
    pbwc__release(memory, &poly->loop);
}

static void pbwc__cutter_release(pbwc__memory *memory, pbwc__cutter *cutter)
{
    pbwc__poly_release(memory, &cutter->poly);
    pbwc__poly_release(memory, &cutter->next);
    pbwc__release(memory, &cutter->side);
    pbwc__release(memory, &cutter->edges);
    pbwc__release(memory, &cutter->cap);
}

static size_t pbwc__loop_end(const pbwc__poly *poly, size_t facet)
{
    return facet + 1 < poly->start.count ? PBWC__INDICES(poly->start)[facet + 1] : poly->loop.count;
}

static int pbwc__open_facet(pbwc__memory *memory, pbwc__poly *poly, pbw_index name)
{
    return pbwc__push(memory, &poly->start, (pbw_index)poly->loop.count) && pbwc__push(memory, &poly->name, name);
}

/* The box with low and high corner, its walls named as in pbw_cells.neighbors. */
static int pbwc__poly_box(pbwc__memory *memory, pbwc__poly *poly, int dim, const double *low, const double *high)
{
    static const unsigned char face[6][4] = { { 0, 4, 6, 2 }, { 1, 3, 7, 5 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 },
                                              { 0, 2, 3, 1 }, { 4, 5, 7, 6 } };
    static const unsigned char edge[4][2] = { { 0, 2 }, { 1, 1 }, { 3, 3 }, { 2, 0 } };     /* corner, wall */
    const unsigned corners = dim == 3 ? 8 : 4;
    double *x;
    unsigned i, k;
    pbwc__poly_clear(poly);
    poly->x.count = 0;
    x = (double *)pbwc__room(memory, &poly->x, corners, 3 * sizeof(double));
    for (i = 0; x != NULL && i < corners; i++, poly->x.count++) {
        for (k = 0; k < 3; k++) {
            x[3 * i + k] = k == 2 && dim == 2 ? 0 : (i >> k & 1) != 0 ? high[k] : low[k];
        }
    }
    for (i = 0; dim == 3 && i < 24; i++) {
        if ((i % 4 == 0 && !pbwc__open_facet(memory, poly, PBW_NONE - 1 - i / 4))
            || !pbwc__push(memory, &poly->loop, face[i / 4][i % 4])) {
            return 0;
        }
    }
    for (i = 0; dim == 2 && i < 4; i++) {
        if (!pbwc__open_facet(memory, poly, PBW_NONE - 1 - edge[i][1])
            || !pbwc__push(memory, &poly->loop, edge[i][0])) {
            return 0;
        }
    }
    return x != NULL;
}

/* The new corner on the edge from p to q, made at its first use.  Returns PBW_NONE if there is no memory. */
static pbw_index pbwc__cut_edge(pbwc__memory *memory, pbwc__cutter *cutter, pbw_index p, pbw_index q)
{
    const pbw_index low = p < q ? p : q, high = p < q ? q : p;
    const double *side = PBWC__DOUBLES(cutter->side);
    pbw_index *edge = PBWC__INDICES(cutter->edges);
    double *x, t;
    size_t i;
    for (i = cutter->edges.count; i > 0; i -= 3) {
        if (edge[i - 3] == low && edge[i - 2] == high) {
            return edge[i - 1];
        }
    }
    x = (double *)pbwc__room(memory, &cutter->poly.x, 1, 3 * sizeof(double));
    edge = (pbw_index *)pbwc__room(memory, &cutter->edges, 3, sizeof(pbw_index));
    if (x == NULL || edge == NULL) {
        return PBW_NONE;
    }
    t = side[low] / (side[low] - side[high]);
    for (i = 0; i < 3; i++) {
        const double *a = PBWC__DOUBLES(cutter->poly.x) + 3 * low, *b = PBWC__DOUBLES(cutter->poly.x) + 3 * high;
        x[i] = a[i] + t * (b[i] - a[i]);
    }
    edge[0] = low;
    edge[1] = high;
    edge[2] = (pbw_index)cutter->poly.x.count++;
    cutter->edges.count += 3;
    return edge[2];
}

/* What is left of one facet's loop in space; notes the cap's edges.  Returns 0 if there is no memory. */
static int pbwc__cut_loop(pbwc__memory *memory, pbwc__cutter *cutter, size_t facet)
{
    const double *side = PBWC__DOUBLES(cutter->side);
    const size_t begin = PBWC__INDICES(cutter->poly.start)[facet], end = pbwc__loop_end(&cutter->poly, facet);
    const size_t old = cutter->side.count, from = cutter->next.loop.count;
    const pbw_index *loop = PBWC__INDICES(cutter->poly.loop);
    pbw_index left = PBW_NONE, first = PBW_NONE;
    pbw_index *out = (pbw_index *)pbwc__room(memory, &cutter->next.loop, 2 * (end - begin), sizeof(pbw_index));
    size_t i, count = 0;
    if (out == NULL || !pbwc__open_facet(memory, &cutter->next, PBWC__INDICES(cutter->poly.name)[facet])) {
        return 0;
    }
    for (i = begin; i < end; i++) {
        const pbw_index a = loop[i], b = loop[i + 1 < end ? i + 1 : begin];
        pbw_index cut;
        if (!(side[a] > 0)) {
            out[count++] = a;
        }
        if ((side[a] > 0) == (side[b] > 0)) {
            continue;
        }
        cut = pbwc__cut_edge(memory, cutter, a, b);
        if (cut == PBW_NONE) {
            return 0;
        }
        out[count++] = cut;
        while (cutter->cap.count + old < cutter->poly.x.count) {
            if (!pbwc__push(memory, &cutter->cap, PBW_NONE)) {
                return 0;
            }
        }
        if (side[b] > 0) {
            left = cut;
        } else if (left != PBW_NONE) {
            PBWC__INDICES(cutter->cap)[cut - old] = left;
        } else {
            first = cut;
        }
    }
    if (first != PBW_NONE) {
        PBWC__INDICES(cutter->cap)[first - old] = left;
    }
    cutter->next.loop.count += count;
    if (count < 3) {                                 /* nothing left, or an edge */
        cutter->next.loop.count = from;
        cutter->next.start.count--;
        cutter->next.name.count--;
    }
    return 1;
}

/* In the plane: the loop of all edges; the cut's own edge starts where the loop leaves the half-plane. */
static int pbwc__cut_polygon(pbwc__memory *memory, pbwc__cutter *cutter, pbw_index name)
{
    const double *side = PBWC__DOUBLES(cutter->side);
    const size_t count = cutter->poly.loop.count;
    size_t i;
    for (i = 0; i < count; i++) {
        const pbw_index *loop = PBWC__INDICES(cutter->poly.loop);
        const pbw_index a = loop[i], b = loop[i + 1 < count ? i + 1 : 0], edge = PBWC__INDICES(cutter->poly.name)[i];
        if (!(side[a] > 0) && (!pbwc__open_facet(memory, &cutter->next, edge)
                               || !pbwc__push(memory, &cutter->next.loop, a))) {
            return 0;
        }
        if ((side[a] > 0) != (side[b] > 0)) {
            const pbw_index cut = pbwc__cut_edge(memory, cutter, a, b);
            if (cut == PBW_NONE || !pbwc__open_facet(memory, &cutter->next, side[b] > 0 ? name : edge)
                || !pbwc__push(memory, &cutter->next.loop, cut)) {
                return 0;
            }
        }
    }
    return 1;
}

/* The facets that close a cut in space: the cycles of new corners, one unless rounding has bent the surface. */
static int pbwc__cut_cap(pbwc__memory *memory, pbwc__cutter *cutter, pbw_index name)
{
    const size_t old = cutter->side.count;
    pbw_index *after = PBWC__INDICES(cutter->cap), i, at, then;
    for (i = 0; i < cutter->cap.count; i++) {
        size_t from = cutter->next.loop.count;
        if (after[i] == PBW_NONE) {
            continue;
        }
        if (!pbwc__open_facet(memory, &cutter->next, name)) {
            return 0;
        }
        for (at = i; after[at] != PBW_NONE; at = then) {
            if (!pbwc__push(memory, &cutter->next.loop, (pbw_index)(at + old))) {
                return 0;
            }
            then = after[at] - (pbw_index)old;
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

/* Keeps the part with n.x <= c, whose new facet gets the name.  Returns 0 if there is no memory. */
static int pbwc__cut(pbwc__memory *memory, pbwc__cutter *cutter, int dim, const double *plane, pbw_index name)
{
    const size_t count = cutter->poly.x.count;
    const double c = plane[dim];
    size_t i, outside = 0;
    double *side, *x;
    pbwc__poly swap;
    cutter->side.count = 0;
    side = (double *)pbwc__room(memory, &cutter->side, count, sizeof(double));
    if (side == NULL) {
        return 0;
    }
    x = PBWC__DOUBLES(cutter->poly.x);
    for (i = 0; i < count; i++) {
        side[i] = plane[0] * x[3 * i] + plane[1] * x[3 * i + 1] + (dim == 3 ? plane[2] * x[3 * i + 2] : 0) - c;
        outside += side[i] > 0;
    }
    if (outside == 0) {
        return 1;
    }
    cutter->side.count = count;
    cutter->edges.count = cutter->cap.count = 0;
    pbwc__poly_clear(&cutter->next);
    if (dim == 2) {
        if (!pbwc__cut_polygon(memory, cutter, name)) {
            return 0;
        }
    } else {
        for (i = 0; i < cutter->poly.start.count; i++) {
            if (!pbwc__cut_loop(memory, cutter, i)) {
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

/* ------------------------------------------------------------------------------------------------------
   Stars: the simplices at a vertex v, numbered from 0, and their other vertices, the links, numbered too.
   Simplex i has the links i0 i1 (i2) with v i0 i1 (i2) positively oriented, and beyond the facet across from its j-th
   link simplex beyond[j] of the star, -1 on the hull.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwc__part { pbw_index simplex; int link[3], beyond[3]; double centre[3]; } pbwc__part;
typedef struct pbwc__link {
    pbw_index vertex;
    int part;                              /* the first that has it */
    double d[3], foot;                     /* from v; the plane between the cells is at foot * d */
    double area[3];                        /* twice the facet's area vector */
} pbwc__link;

typedef struct pbwc__map { pbwc__array slots; size_t mask, count; uint32_t epoch; } pbwc__map;
typedef struct pbwc__slot { uint32_t epoch; pbw_index key; int value; } pbwc__slot;

/* The place of a key, with an epoch of its own if it is new.  NULL: no memory. */
static pbwc__slot *pbwc__find(pbwc__memory *memory, pbwc__map *map, pbw_index key)
{
    pbwc__slot *slots = (pbwc__slot *)map->slots.data, *slot;
    size_t i;
    if (2 * map->count >= map->mask) {               /* at first, or too full: twice the slots */
        const size_t size = map->mask != 0 ? 2 * (map->mask + 1) : 256;
        pbwc__map larger;
        memset(&larger, 0, sizeof larger);
        if (!pbwc__resize(memory, &larger.slots, size * sizeof *slot)) {
            return NULL;
        }
        memset(larger.slots.data, 0, size * sizeof *slot);
        larger.mask = size - 1;
        larger.epoch = 1;
        for (i = 0; map->mask != 0 && i <= map->mask; i++) {
            if (slots[i].epoch == map->epoch) {
                slot = pbwc__find(memory, &larger, slots[i].key);
                slot->epoch = 1;
                slot->key = slots[i].key;
                slot->value = slots[i].value;
                larger.count++;
            }
        }
        pbwc__release(memory, &map->slots);
        *map = larger;
        slots = (pbwc__slot *)map->slots.data;
    }
    for (i = (key * 2654435761u >> 7) & map->mask; slots[i].epoch == map->epoch && slots[i].key != key; ) {
        i = (i + 1) & map->mask;
    }
    return slots + i;
}

/* The number of a key, `fresh` if it had none.  Returns -1 if there is no memory. */
static int pbwc__number(pbwc__memory *memory, pbwc__map *map, pbw_index key, int fresh)
{
    pbwc__slot *slot = pbwc__find(memory, map, key);
    if (slot == NULL) {
        return -1;
    }
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
#define PBWC__CHUNK   8192                 /* simplices */

/* The other corners of a simplex, so that it is positively oriented with the i-th before them. */
static const unsigned char pbwc__other3[4][3] = { { 1, 2, 3 }, { 0, 3, 2 }, { 3, 0, 1 }, { 2, 1, 0 } };
static const unsigned char pbwc__other2[3][3] = { { 1, 2, 0 }, { 2, 0, 0 }, { 0, 1, 0 } };

typedef struct pbwc__range {               /* what a range of points gives, if asked */
    pbwc__array neighbors, areas, loop_counts, loops, vertices, rays;
} pbwc__range;

typedef struct pbwc__work {                /* of one range */
    pbwc__job *job;
    pbwc__memory *memory;
    pbwc__range *out;
    pbwc__array parts, links;
    pbwc__map part_of, link_of;
    pbwc__cutter cutter;
    pbwc__centre *centres;
    pbw_index site;                        /* the vertex of the star */
    int open, good;                        /* the star: at the hull; with good centres, none far from the domain */
} pbwc__work;

#define PBWC__GRID 64

struct pbwc__period {
    int dim, apexes;                       /* apexes: dim + 1 points far out, where the others are flat */
    unsigned axes;
    size_t count, total;                   /* points; with copies */
    pbwc__memory *memory;
    double size[3], unit[3], margin[3];    /* of the box; all are multiples of the units; of the padded box */
    double low[3], high[3];                /* of the grid */
    double heaviest, lightest;             /* weight */
    double from[3], to[3];                 /* bounds of the marked part */
    pbwc__array x, w, source, marks;       /* source: of each copy */
    int marked;                            /* new marks in this round */
};

struct pbwc__job {
    const pbw_mesh *mesh;
    pbwc__memory memory;
    pbwc__period *period;                  /* NULL: not periodic */
    unsigned what;
    int bounded, weighted;
    size_t count;                          /* cells: of the mesh's first points */
    double low[3], high[3], slack[3];      /* of the box, else infinite; slack: for its rounding */
    double extent[3];                      /* of the domain */
    const double *planes;                  /* of the domain: normal and offset */
    size_t plane_count;
    pbwc__poly domain;
    pbwc__array merged, ranges;            /* per simplex: the first whose centre is the same place */
    size_t grain;
    pbw_cells *cells;
    double *volumes, *centroids;
    size_t *first;
    pbwc__array states, shares;            /* per point: PBWC__OPEN and so on; per chunk of simplices: its shares */
};

#define PBWC__PARTS(work) ((pbwc__part *)(work)->parts.data)
#define PBWC__LINKS(work) ((pbwc__link *)(work)->links.data)

static int pbwc__centres_new(pbwc__memory *memory, pbwc__array *centres)
{
    size_t i;
    if (!pbwc__resize(memory, centres, PBWC__CENTRES * sizeof(pbwc__centre))) {
        return 0;
    }
    for (i = 0; i < PBWC__CENTRES; i++) {
        ((pbwc__centre *)centres->data)[i].simplex = PBW_NONE;
    }
    return 1;
}

/* Is a + x in all half-spaces of the domain, for certain?  radius: sum of |x|. */
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

/* Centre of a simplex relative to its first corner; kept, as the other corners need it too. */
static const pbwc__centre *pbwc__centre_kept(const pbwc__job *job, pbwc__centre *centres, pbw_index simplex)
{
    pbwc__centre *centre = centres + simplex % PBWC__CENTRES;
    const size_t dim = (size_t)job->mesh->dim;
    if (centre->simplex != simplex) {
        const double *a = job->mesh->points + job->mesh->simplices[simplex * (dim + 1)] * dim;
        double radius = 0;
        size_t k;
        centre->simplex = simplex;
        centre->inside = centre->good = pbwc__centre_of(job->mesh, simplex, centre->x);
        for (k = 0; k < dim; k++) {
            radius += fabs(centre->x[k]);
        }
        for (k = 0; k < dim; k++) {                  /* if in doubt, cut */
            const double at = a[k] + centre->x[k], slack = 1e-12 * radius + job->slack[k];
            centre->inside &= at - job->low[k] > slack && job->high[k] - at > slack;
        }
        if (job->plane_count > 0) {
            centre->inside &= pbwc__in_planes(job, a, centre->x, radius);
        }
    }
    return centre;
}

/* The number of the link `vertex`; a new one is put down with its bisector.  Returns -1 if there is no memory. */
static int pbwc__link_number(pbwc__work *work, pbw_index v, pbw_index vertex, int part)
{
    const pbw_mesh *mesh = work->job->mesh;
    const size_t dim = (size_t)mesh->dim;
    const int number = pbwc__number(work->memory, &work->link_of, vertex, (int)work->links.count);
    pbwc__link *link;
    double square = 0;
    size_t k;
    if (number != (int)work->links.count) {
        return number;
    }
    link = (pbwc__link *)pbwc__room(work->memory, &work->links, 1, sizeof *link);
    if (link == NULL) {
        return -1;
    }
    memset(link, 0, sizeof *link);
    link->vertex = vertex;
    link->part = part;
    for (k = 0; k < dim; k++) {
        link->d[k] = mesh->points[vertex * dim + k] - mesh->points[v * dim + k];
        square += link->d[k] * link->d[k];
    }
    link->foot = 0.5;
    if (mesh->weights != NULL) {
        link->foot += (mesh->weights[v] - mesh->weights[vertex]) / (2 * square);
    }
    work->links.count++;
    return number;
}

/* Gathers the star of v, breadth first from its first simplex.  Returns 0 if there is no memory. */
static int pbwc__gather(pbwc__work *work, pbw_index v)
{
    const pbw_mesh *mesh = work->job->mesh;
    const size_t dim = (size_t)mesh->dim;
    const double *site = mesh->points + v * dim;
    size_t i, j, k;
    work->parts.count = work->links.count = 0;
    work->site = v;
    work->open = 0;
    work->good = 1;
    pbwc__map_clear(&work->part_of);
    pbwc__map_clear(&work->link_of);
    if (pbwc__room(work->memory, &work->parts, 1, sizeof(pbwc__part)) == NULL
        || pbwc__number(work->memory, &work->part_of, mesh->incident[v], 0) < 0) {
        return 0;
    }
    PBWC__PARTS(work)[work->parts.count++].simplex = mesh->incident[v];
    for (i = 0; i < work->parts.count; i++) {
        const pbw_index simplex = PBWC__PARTS(work)[i].simplex;
        const pbw_index *corner = mesh->simplices + simplex * (dim + 1);
        const pbw_index *beyond = mesh->neighbors + simplex * (dim + 1);
        const pbwc__centre *centre = pbwc__centre_kept(work->job, work->centres, simplex);
        const double *a = mesh->points + corner[0] * dim;
        const unsigned char *other;
        pbwc__part *part;
        for (k = 0; corner[k] != v; k++) {
        }
        other = dim == 3 ? pbwc__other3[k] : pbwc__other2[k];
        work->good &= centre->good;
        for (k = 0; k < dim; k++) {
            PBWC__PARTS(work)[i].centre[k] = centre->x[k] + (a[k] - site[k]);
            work->good &= fabs(PBWC__PARTS(work)[i].centre[k]) < 4 * work->job->extent[k];
        }
        for (j = 0; j < dim; j++) {
            const pbw_index next = beyond[other[j]];
            const int link = pbwc__link_number(work, v, corner[other[j]], (int)i);
            int number = -1;
            if (next != PBW_NONE) {
                number = pbwc__number(work->memory, &work->part_of, next, (int)work->parts.count);
                part = (pbwc__part *)pbwc__room(work->memory, &work->parts, 1, sizeof *part);
                if (number < 0 || part == NULL) {
                    return 0;
                }
                if (number == (int)work->parts.count) {
                    part->simplex = next;
                    work->parts.count++;
                }
            } else {
                work->open = 1;
            }
            if (link < 0) {
                return 0;
            }
            PBWC__PARTS(work)[i].link[j] = link;
            PBWC__PARTS(work)[i].beyond[j] = number;
        }
    }
    return 1;
}

/* ------------------------------------------------------------------------------------------------------
   Facets read off stars.  Going counter-clockwise around link u, seen from u, the simplices' centres S T ... are the
   corners of the facet towards u; twice its area vector is the sum of S x T.
   ------------------------------------------------------------------------------------------------------ */
static void pbwc__cross(const double *s, const double *t, double *x)
{
    x[0] = s[1] * t[2] - s[2] * t[1];
    x[1] = s[2] * t[0] - s[0] * t[2];
    x[2] = s[0] * t[1] - s[1] * t[0];
}

static void pbwc__add_areas(pbwc__work *work)
{
    const pbwc__part *parts = PBWC__PARTS(work);
    pbwc__link *links = PBWC__LINKS(work);
    int i, j, k;
    for (i = 0; i < (int)work->parts.count; i++) {
        const pbwc__part *p = parts + i;
        for (j = 0; work->job->mesh->dim == 3 && j < 3; j++) {
            if (p->beyond[j] > i) {                  /* the other way it is the other simplex's */
                double across[3];
                pbwc__cross(p->centre, parts[p->beyond[j]].centre, across);
                for (k = 0; k < 3; k++) {
                    links[p->link[(j + 2) % 3]].area[k] += across[k];
                    links[p->link[(j + 1) % 3]].area[k] -= across[k];
                }
            }
        }
        if (work->job->mesh->dim == 2 && p->beyond[0] >= 0) {
            const pbwc__part *q = parts + p->beyond[0];
            links[p->link[1]].area[0] = q->centre[1] - p->centre[1];
            links[p->link[1]].area[1] = p->centre[0] - q->centre[0];
        }
    }
}

/* Two numbers or three at the end of an array of doubles.  Returns their number there, PBW_NONE if there is no
   memory. */
static pbw_index pbwc__push_vector(pbwc__work *work, pbwc__array *array, const double *x)
{
    const size_t dim = (size_t)work->job->mesh->dim;
    double *place = (double *)pbwc__room(work->memory, array, dim, sizeof(double));
    size_t k;
    if (place == NULL) {
        return PBW_NONE;
    }
    for (k = 0; k < dim; k++) {
        place[k] = x[k];
    }
    array->count += dim;
    return (pbw_index)(array->count / dim - 1);
}

/* The direction from the hull facet across from link j of a part, outward, as an entry of a loop.  Its number counts
   the range's own rays.  Returns 0 if there is no memory. */
static int pbwc__push_ray(pbwc__work *work, const pbwc__part *part, int j)
{
    const pbwc__link *links = PBWC__LINKS(work);
    const int dim = work->job->mesh->dim;
    const double *a = links[part->link[(j + dim - 1) % dim]].d, *c = links[part->link[(j + 1) % dim]].d;
    double ray[3] = { 0, 0, 0 }, unit[2][3], length[2] = { 0, 0 };
    pbw_index number;
    int k;
    for (k = 0; k < dim; k++) {                      /* first to length 1: products must not vanish */
        length[0] = fabs(a[k]) > length[0] ? fabs(a[k]) : length[0];
        length[1] = fabs(c[k]) > length[1] ? fabs(c[k]) : length[1];
    }
    for (k = 0; k < 3; k++) {
        unit[0][k] = k < dim ? a[k] / length[0] : 0;
        unit[1][k] = k < dim ? c[k] / length[1] : 0;
    }
    if (dim == 3) {
        pbwc__cross(unit[0], unit[1], ray);
    } else {
        ray[0] = j == 0 ? -unit[0][1] : unit[0][1];  /* the facet goes to the other link */
        ray[1] = j == 0 ? unit[0][0] : -unit[0][0];
    }
    length[0] = sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
    for (k = 0; k < dim && length[0] > 0; k++) {
        ray[k] /= length[0];
    }
    number = pbwc__push_vector(work, &work->out->rays, ray);
    return number != PBW_NONE && pbwc__push(work->memory, &work->out->loops, PBW_NONE - 1 - number);
}

/* A corner of a loop: the centre of a part, not twice in a row where centres are merged. */
static int pbwc__push_centre(pbwc__work *work, const pbwc__part *part, size_t begin)
{
    const pbw_index *merged = PBWC__INDICES(work->job->merged);
    const pbw_index vertex = merged != NULL ? merged[part->simplex] : part->simplex;
    pbwc__array *loops = &work->out->loops;
    if (merged != NULL && loops->count > begin && PBWC__INDICES(*loops)[loops->count - 1] == vertex) {
        return 1;
    }
    return pbwc__push(work->memory, loops, vertex);
}

/* In space: the part after p counter-clockwise around the link u (step 1), or clockwise (2); -1 beyond the hull. */
static int pbwc__around(const pbwc__part *p, int u, int step)
{
    int j = 0;
    while (p->link[j] != u) {
        j++;
    }
    return p->beyond[(j + step) % 3];
}

/* The loop of a link's facet in space, with two rays if it is open.  Returns 0 if there is no memory. */
static int pbwc__loop3(pbwc__work *work, int u)
{
    const pbwc__part *parts = PBWC__PARTS(work);
    const pbwc__array *loops = &work->out->loops;
    const size_t begin = loops->count;
    const int start = PBWC__LINKS(work)[u].part;
    int first = start, at, then, j;
    while ((then = pbwc__around(parts + first, u, 2)) >= 0 && then != start) {
        first = then;
    }
    first = then < 0 ? first : start;
    for (at = first; ; at = then) {
        if (!pbwc__push_centre(work, parts + at, begin)) {
            return 0;
        }
        then = pbwc__around(parts + at, u, 1);
        if (then < 0 || then == first) {
            break;
        }
    }
    if (then < 0) {
        for (j = 0; parts[at].link[j] != u; j++) {
        }
        if (!pbwc__push_ray(work, parts + at, (j + 1) % 3)) {
            return 0;
        }
        for (j = 0; parts[first].link[j] != u; j++) {
        }
        return pbwc__push_ray(work, parts + first, (j + 2) % 3);
    }
    if (loops->count > begin + 1 && PBWC__INDICES(*loops)[begin] == PBWC__INDICES(*loops)[loops->count - 1]) {
        work->out->loops.count--;                    /* merged across the start */
    }
    return 1;
}

/* The other link of the hull facet at the end of an open ring around u: at its last part (step 1) or first (2). */
static const double *pbwc__ring_end(const pbwc__work *work, int part, int u, int step)
{
    const pbwc__part *p = PBWC__PARTS(work) + part;
    int j = 0;
    while (p->link[j] != u) {
        j++;
    }
    return work->job->mesh->points + 3 * (size_t)PBWC__LINKS(work)[p->link[(j + 3 - step) % 3]].vertex;
}

/* Has an open facet in space an area in the true diagram?  Not if it is a ray: all centres are at one place, and the
   hull facets at both ends lie in one plane. */
static int pbwc__is_open_facet(const pbwc__work *work, int u)
{
    const pbw_index *merged = PBWC__INDICES(work->job->merged);
    const pbw_mesh *mesh = work->job->mesh;
    const pbwc__part *parts = PBWC__PARTS(work);
    const int start = PBWC__LINKS(work)[u].part;
    int end[3] = { 0, start, start }, step, then;
    for (step = 1; step <= 2; step++) {
        while ((then = pbwc__around(parts + end[step], u, step)) >= 0) {
            end[step] = then;
            if (merged[parts[then].simplex] != merged[parts[start].simplex]) {
                return 1;
            }
        }
    }
    return pbw_orient3(mesh->points + 3 * (size_t)work->site, mesh->points + 3 * (size_t)PBWC__LINKS(work)[u].vertex,
                       pbwc__ring_end(work, end[1], u, 1), pbwc__ring_end(work, end[2], u, 2)) != 0;
}

/* Has the facet of a link an area in the true diagram? */
static int pbwc__is_facet(const pbwc__work *work, int u)
{
    const pbw_index *merged = PBWC__INDICES(work->job->merged);
    const pbwc__part *parts = PBWC__PARTS(work);
    const int start = PBWC__LINKS(work)[u].part, dim = work->job->mesh->dim;
    int at = start, then, differ = 0;
    pbw_index last;
    if (merged == NULL) {
        return 1;
    }
    last = merged[parts[start].simplex];
    if (dim == 2) {                                  /* the triangles on both sides of the edge to u */
        then = parts[start].beyond[parts[start].link[0] == u];
        return then < 0 || merged[parts[then].simplex] != last;
    }
    do {
        then = pbwc__around(parts + at, u, 1);
        if (then < 0) {
            return pbwc__is_open_facet(work, u);
        }
        differ += merged[parts[then].simplex] != last;
        last = merged[parts[then].simplex];
        at = then;
    } while (at != start);
    return differ > 2;                               /* a ring of two places is an edge */
}

static int pbwc__facet_done(pbwc__work *work, pbw_index neighbor, double area, size_t loop_begin)
{
    pbwc__range *out = work->out;
    double *place = (double *)pbwc__room(work->memory, &out->areas, 1, sizeof(double));
    if (place == NULL || !pbwc__push(work->memory, &out->neighbors, neighbor)
        || ((work->job->what & PBW_CELLS_SHAPES) != 0
            && !pbwc__push(work->memory, &out->loop_counts, (pbw_index)(out->loops.count - loop_begin)))) {
        return 0;
    }
    *place = area;
    out->areas.count++;
    return 1;
}

static double pbwc__area_of(const pbwc__link *link, int dim)
{
    const double square = link->d[0] * link->d[0] + link->d[1] * link->d[1] + link->d[2] * link->d[2];
    const double along = link->d[0] * link->area[0] + link->d[1] * link->area[1] + link->d[2] * link->area[2];
    return along / sqrt(square) / (dim == 3 ? 2 : 1);
}

static int pbwc__star_facets3(pbwc__work *work)
{
    int u;
    for (u = 0; u < (int)work->links.count; u++) {
        const pbwc__link *link = PBWC__LINKS(work) + u;
        const size_t begin = work->out->loops.count;
        int open = 0, then = link->part;
        if (!pbwc__is_facet(work, u)) {
            continue;
        }
        do {
            then = work->open ? pbwc__around(PBWC__PARTS(work) + then, u, 1) : link->part;
            open = then < 0;
        } while (!open && then != link->part);
        if (((work->job->what & PBW_CELLS_SHAPES) != 0 && !pbwc__loop3(work, u))
            || !pbwc__facet_done(work, link->vertex, open ? HUGE_VAL : pbwc__area_of(link, 3), begin)) {
            return 0;
        }
    }
    return 1;
}

/* An edge of a cell in the plane, between the centres of two parts, of which one may be -1: then it is a ray. */
static int pbwc__edge2(pbwc__work *work, int from, int to, const pbwc__link *link)
{
    const pbwc__part *parts = PBWC__PARTS(work);
    const pbw_index *merged = PBWC__INDICES(work->job->merged);
    const size_t begin = work->out->loops.count;
    if (from >= 0 && to >= 0 && merged != NULL && merged[parts[from].simplex] == merged[parts[to].simplex]) {
        return 1;                                    /* one place: no edge */
    }
    if ((work->job->what & PBW_CELLS_SHAPES) != 0
        && !((from >= 0 ? pbwc__push_centre(work, parts + from, begin) : pbwc__push_ray(work, parts + to, 1))
             && (to >= 0 ? pbwc__push_centre(work, parts + to, begin) : pbwc__push_ray(work, parts + from, 0)))) {
        return 0;
    }
    return pbwc__facet_done(work, link->vertex, from >= 0 && to >= 0 ? pbwc__area_of(link, 2) : HUGE_VAL, begin);
}

static int pbwc__star_facets2(pbwc__work *work)
{
    const pbwc__part *parts = PBWC__PARTS(work);
    const pbwc__link *links = PBWC__LINKS(work);
    int first = 0, at;
    while (parts[first].beyond[1] >= 0 && parts[first].beyond[1] != 0) {     /* clockwise, to the hull or around */
        first = parts[first].beyond[1];
    }
    first = parts[first].beyond[1] < 0 ? first : 0;
    if (work->open && !pbwc__edge2(work, -1, first, links + parts[first].link[0])) {
        return 0;
    }
    for (at = first; ; at = parts[at].beyond[0]) {
        if (!pbwc__edge2(work, at, parts[at].beyond[0], links + parts[at].link[1])) {
            return 0;
        }
        if (parts[at].beyond[0] < 0 || parts[at].beyond[0] == first) {
            return 1;
        }
    }
}

/* ------------------------------------------------------------------------------------------------------
   Volumes and centroids of cells, from one pass over the facets of the mesh.  The facet a b c between simplices with
   centres S and T gives to the cell of a, for its edge ab and likewise ac, the tetrahedron of a, the foot of the
   plane between the cells on ab, S and T: 6 times its volume is foot (b - a).((S - a) x (T - a)), with a sign.  In
   the plane the edge ab gives to a the triangle a S T.
   Simplices are taken in chunks; a chunk adds up what it gives to each vertex.  A vertex all of whose simplices are
   in one chunk is done; of the others (on facets between chunks) the chunks' shares are added in the chunks' order.
   Holds: which sums are added, and in which order, depends on the mesh alone.
   ------------------------------------------------------------------------------------------------------ */
#define PBWC__OPEN   1                     /* state of a vertex: on the hull */
#define PBWC__OUT    2                     /* some centre may be outside the domain */
#define PBWC__BORDER 4                     /* in several chunks */

typedef struct pbwc__share { double sum[4]; pbw_index vertex; int state; } pbwc__share;   /* moments, volume */

typedef struct pbwc__adder {               /* of one chunk */
    const pbwc__job *job;
    pbwc__memory *memory;
    pbwc__centre *centres;
    pbwc__map number_of;
    pbwc__array shares;
} pbwc__adder;

/* Ends the sums of a vertex: moments * 24 (in the plane 6), volume * 6 (2). */
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

/* Where the plane between the cells of a and b crosses the edge d from a to b, from 0 at a to 1 at b. */
static double pbwc__foot(const double *weights, pbw_index a, pbw_index b, const double *d)
{
    return weights == NULL ? 0.5 : 0.5 + (weights[a] - weights[b]) / (2 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
}

static void pbwc__give(double *sum, double volume, const double *middle, const double *site)
{
    int k;
    for (k = 0; k < 3; k++) {
        sum[k] += volume * (middle[k] - 3 * site[k]);
    }
    sum[3] += volume;
}

/* A facet in space; all relative to its corner a: edge[0] to b, edge[1] to c, the centres s and t.  With X = s x t
   the determinants of the edges ab and ca are b.X and -c.X, that of bc is c.X - b.X + (t - s).(b x c). */
static void pbwc__add_facet3(const double edge[2][3], const double *s, const double *t, const double *foot,
                             double *const sum[3])
{
    static const double origin[3] = { 0, 0, 0 };
    const double *b = edge[0], *c = edge[1];
    double across[3], normal[3], middle[3], ab, bc, ca;
    int k;
    pbwc__cross(s, t, across);
    pbwc__cross(b, c, normal);
    ab = b[0] * across[0] + b[1] * across[1] + b[2] * across[2];
    ca = -(c[0] * across[0] + c[1] * across[1] + c[2] * across[2]);
    bc = (t[0] - s[0]) * normal[0] + (t[1] - s[1]) * normal[1] + (t[2] - s[2]) * normal[2] - ab - ca;
    for (k = 0; k < 3; k++) {
        middle[k] = foot[0] * b[k] + s[k] + t[k];
    }
    pbwc__give(sum[0], foot[0] * ab, middle, origin);
    pbwc__give(sum[1], (1 - foot[0]) * ab, middle, b);
    for (k = 0; k < 3; k++) {
        middle[k] = b[k] + foot[1] * (c[k] - b[k]) + s[k] + t[k];
    }
    pbwc__give(sum[1], foot[1] * bc, middle, b);
    pbwc__give(sum[2], (1 - foot[1]) * bc, middle, c);
    for (k = 0; k < 3; k++) {
        middle[k] = (1 - foot[2]) * c[k] + s[k] + t[k];
    }
    pbwc__give(sum[2], foot[2] * ca, middle, c);
    pbwc__give(sum[0], (1 - foot[2]) * ca, middle, origin);
}

/* The same in the plane, for an edge ab. */
static void pbwc__add_facet2(const double *b, const double *s, const double *t, double *const sum[3])
{
    const double u[2] = { s[0] - b[0], s[1] - b[1] }, v[2] = { t[0] - b[0], t[1] - b[1] };
    const double at_a = t[0] * s[1] - t[1] * s[0], at_b = u[0] * v[1] - u[1] * v[0];
    sum[0][0] += at_a * (s[0] + t[0]);
    sum[0][1] += at_a * (s[1] + t[1]);
    sum[0][3] += at_a;
    sum[1][0] += at_b * (u[0] + v[0]);
    sum[1][1] += at_b * (u[1] + v[1]);
    sum[1][3] += at_b;
}

/* Facet j of a simplex, towards `next`; share: of the simplex's corners. */
static PBWC__INLINE void pbwc__add_facet(pbwc__adder *adder, size_t dim, pbw_index simplex, pbw_index next,
                                         const unsigned char *other, pbwc__share *const *share)
{
    const pbw_mesh *mesh = adder->job->mesh;
    const pbw_index *corner = mesh->simplices + simplex * (dim + 1), *beyond = mesh->simplices + next * (dim + 1);
    const double *x = mesh->points, *a = x + corner[other[0]] * dim;
    const double *near = pbwc__centre_kept(adder->job, adder->centres, simplex)->x, *far;
    double edge[3][3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } }, s[3] = { 0, 0, 0 }, t[3] = { 0, 0, 0 }, foot[3];
    double *sum[3] = { NULL, NULL, NULL };
    size_t i, k;
    for (k = 0; k < dim; k++) {
        s[k] = near[k] + (x[corner[0] * dim + k] - a[k]);
        sum[k] = share[other[k]]->sum;
    }
    far = pbwc__centre_kept(adder->job, adder->centres, next)->x;
    for (k = 0; k < dim; k++) {
        t[k] = far[k] + (x[beyond[0] * dim + k] - a[k]);
        for (i = 0; i + 1 < dim; i++) {
            edge[i][k] = x[corner[other[i + 1]] * dim + k] - a[k];
        }
        edge[2][k] = edge[1][k] - edge[0][k];
    }
    if (dim == 2) {
        pbwc__add_facet2(edge[0], s, t, sum);
        return;
    }
    foot[0] = pbwc__foot(mesh->weights, corner[other[0]], corner[other[1]], edge[0]);
    foot[1] = pbwc__foot(mesh->weights, corner[other[1]], corner[other[2]], edge[2]);
    foot[2] = pbwc__foot(mesh->weights, corner[other[2]], corner[other[0]], edge[1]);
    pbwc__add_facet3((const double (*)[3])edge, s, t, foot, sum);
}

/* What a simplex gives, and the states of its corners.  Returns 0 if there is no memory. */
static PBWC__INLINE int pbwc__add_simplex(pbwc__adder *adder, size_t dim, pbw_index simplex, size_t from, size_t to)
{
    const pbw_mesh *mesh = adder->job->mesh;
    const pbw_index *corner = mesh->simplices + simplex * (dim + 1), *beyond = mesh->neighbors + simplex * (dim + 1);
    const int out = pbwc__centre_kept(adder->job, adder->centres, simplex)->inside ? 0 : PBWC__OUT;
    pbwc__share *share[4];
    size_t i, k;
    int number[4];
    if (pbwc__room(adder->memory, &adder->shares, 4, sizeof(pbwc__share)) == NULL) {
        return 0;
    }
    for (i = 0; i <= dim; i++) {
        pbwc__share *fresh = (pbwc__share *)adder->shares.data + adder->shares.count;
        number[i] = pbwc__number(adder->memory, &adder->number_of, corner[i], (int)adder->shares.count);
        if (number[i] == (int)adder->shares.count) {
            memset(fresh, 0, sizeof *fresh);
            fresh->vertex = corner[i];
            adder->shares.count++;
        } else if (number[i] < 0) {
            return 0;
        }
        share[i] = (pbwc__share *)adder->shares.data + number[i];
        share[i]->state |= out;
    }
    for (i = 0; i <= dim; i++) {
        const unsigned char *other = dim == 3 ? pbwc__other3[i] : pbwc__other2[i];
        const int state = beyond[i] == PBW_NONE ? PBWC__OPEN : beyond[i] < from || beyond[i] >= to ? PBWC__BORDER : 0;
        for (k = 0; state != 0 && k < dim; k++) {
            share[other[k]]->state |= state;
        }
        if (beyond[i] != PBW_NONE && beyond[i] > simplex) {
            pbwc__add_facet(adder, dim, simplex, beyond[i], other, share);
        }
    }
    return 1;
}

static pbw_status pbwc__add_chunk(void *arg, size_t from, size_t to)
{
    pbwc__job *job = (pbwc__job *)arg;
    pbwc__array centres, *shares = (pbwc__array *)job->shares.data + from / PBWC__CHUNK;
    pbwc__share *share;
    pbwc__adder adder;
    size_t i, left = 0;
    int good;
    memset(&adder, 0, sizeof adder);
    memset(&centres, 0, sizeof centres);
    adder.job = job;
    adder.memory = &job->memory;
    good = pbwc__centres_new(&job->memory, &centres);
    adder.centres = (pbwc__centre *)centres.data;
    adder.number_of.epoch = 1;
    for (i = from; good && i < to; i++) {
        good = job->mesh->dim == 3 ? pbwc__add_simplex(&adder, 3, (pbw_index)i, from, to)
                                   : pbwc__add_simplex(&adder, 2, (pbw_index)i, from, to);
    }
    share = (pbwc__share *)adder.shares.data;
    for (i = 0; good && i < adder.shares.count; i++) {
        if ((share[i].state & PBWC__BORDER) != 0) {
            share[left++] = share[i];
        } else if (share[i].vertex < job->count) {
            pbwc__set_cell(job, share[i].vertex, share[i].sum);
            ((unsigned char *)job->states.data)[share[i].vertex] = (unsigned char)share[i].state;
        }
    }
    pbwc__release(&job->memory, &centres);
    pbwc__release(&job->memory, &adder.number_of.slots);
    adder.shares.count = left;
    *shares = adder.shares;
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Adds the shares of vertices from..to-1, in the order of the chunks. */
static pbw_status pbwc__add_shares(void *arg, size_t from, size_t to)
{
    pbwc__job *job = (pbwc__job *)arg;
    const size_t dim = (size_t)job->mesh->dim, chunks = job->shares.count;
    unsigned char *state = (unsigned char *)job->states.data;
    size_t c, i, k;
    for (c = 0; c < chunks; c++) {
        const pbwc__array *shares = (const pbwc__array *)job->shares.data + c;
        const pbwc__share *share = (const pbwc__share *)shares->data;
        for (i = 0; i < shares->count; i++, share++) {
            const size_t v = share->vertex;
            if (v >= from && v < to) {
                for (k = 0; k < dim; k++) {
                    job->centroids[v * dim + k] = share->sum[k] + (state[v] != 0 ? job->centroids[v * dim + k] : 0);
                }
                job->volumes[v] = share->sum[3] + (state[v] != 0 ? job->volumes[v] : 0);
                state[v] = (unsigned char)(state[v] | share->state);
            }
        }
    }
    for (i = from; i < to; i++) {
        if ((state[i] & PBWC__BORDER) != 0) {
            double sum[4] = { 0, 0, 0, 0 };
            for (k = 0; k < dim; k++) {
                sum[k] = job->centroids[i * dim + k];
            }
            sum[3] = job->volumes[i];
            pbwc__set_cell(job, (pbw_index)i, sum);
            state[i] = (unsigned char)(state[i] & ~PBWC__BORDER);
        }
        if ((state[i] & PBWC__OPEN) != 0 && !job->bounded) {
            memcpy(job->centroids + i * dim, job->mesh->points + i * dim, dim * sizeof(double));
            job->volumes[i] = HUGE_VAL;
        }
    }
    return PBW_OK;
}

/* All volumes and centroids but those of cells that must be cut; the states tell which. */
static pbw_status pbwc__add_up(pbwc__job *job, const pbw_options *options)
{
    const size_t simplices = job->mesh->simplex_count, count = job->cells->cell_count;
    const size_t chunks = (simplices + PBWC__CHUNK - 1) / PBWC__CHUNK, dim = (size_t)job->mesh->dim;
    size_t i;
    pbw_status status;
    if (!pbwc__resize(&job->memory, &job->states, count + 1)
        || !pbwc__resize(&job->memory, &job->shares, chunks * sizeof(pbwc__array) + 1)) {
        return PBW_ERROR_MEMORY;
    }
    memset(job->states.data, 0, count + 1);
    memset(job->shares.data, 0, chunks * sizeof(pbwc__array) + 1);
    memset(job->volumes, 0, count * sizeof(double));
    if (count > 0) {
        memcpy(job->centroids, job->mesh->points, count * dim * sizeof(double));
    }
    job->shares.count = chunks;
    status = pbw_for(options, simplices, PBWC__CHUNK, pbwc__add_chunk, job);
    if (status == PBW_OK) {
        status = pbw_for(options, count, count / 16 + 1, pbwc__add_shares, job);
    }
    for (i = 0; i < chunks; i++) {
        pbwc__release(&job->memory, (pbwc__array *)job->shares.data + i);
    }
    pbwc__release(&job->memory, &job->shares);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   Cells cut from the domain, for what the star cannot give: corners outside the domain, sites on the hull.
   ------------------------------------------------------------------------------------------------------ */
/* The domain's polytope relative to the site, cut by the bisectors of all links, or (merge) of those that have a
   facet in the true diagram.  Returns 0 if there is no memory. */
static int pbwc__cut_cell(pbwc__work *work, pbw_index v, int merge)
{
    const pbwc__job *job = work->job;
    const size_t dim = (size_t)job->mesh->dim, corners = job->domain.x.count, facets = job->domain.start.count;
    const double *from = PBWC__DOUBLES(job->domain.x), *site = job->mesh->points + v * dim;
    const unsigned axes = job->period != NULL ? job->period->axes : 0;
    pbwc__poly *poly = &work->cutter.poly;
    double *x;
    size_t i, k;
    int u;
    pbwc__poly_clear(poly);
    poly->x.count = 0;
    x = (double *)pbwc__room(work->memory, &poly->x, corners, 3 * sizeof(double));
    if (x == NULL) {
        return 0;
    }
    for (i = 0; i < corners; i++) {
        for (k = 0; k < 3; k++) {
            x[3 * i + k] = from[3 * i + k] - (k >= dim || (axes >> k & 1) != 0 ? 0 : site[k]);
        }
    }
    poly->x.count = corners;
    for (i = 0; i < facets; i++) {
        if (!pbwc__open_facet(work->memory, poly, PBWC__INDICES(job->domain.name)[i])) {
            return 0;
        }
        for (k = PBWC__INDICES(job->domain.start)[i]; k < pbwc__loop_end(&job->domain, i); k++) {
            if (!pbwc__push(work->memory, &poly->loop, PBWC__INDICES(job->domain.loop)[k])) {
                return 0;
            }
        }
    }
    for (u = 0; u < (int)work->links.count; u++) {
        const pbwc__link *link = PBWC__LINKS(work) + u;
        double plane[4] = { 0, 0, 0, 0 }, square = 0;
        for (k = 0; k < dim; k++) {
            plane[k] = link->d[k];
            square += link->d[k] * link->d[k];
        }
        plane[dim] = link->foot * square;
        if ((!merge || pbwc__is_facet(work, u))
            && !pbwc__cut(work->memory, &work->cutter, (int)dim, plane, (pbw_index)u)) {
            return 0;
        }
    }
    return 1;
}

/* The polytope of a closed star with good centres. */
static int pbwc__star_poly(pbwc__work *work)
{
    const pbwc__part *parts = PBWC__PARTS(work);
    const int count = (int)work->parts.count;
    pbwc__memory *memory = work->memory;
    pbwc__poly *poly = &work->cutter.poly;
    double *x;
    int i, u, at = 0, start;
    pbwc__poly_clear(poly);
    poly->x.count = 0;
    x = (double *)pbwc__room(memory, &poly->x, work->parts.count, 3 * sizeof(double));
    for (i = 0; x != NULL && i < count; i++) {
        memcpy(x + 3 * i, parts[i].centre, 2 * sizeof(double));
        x[3 * i + 2] = work->job->mesh->dim == 3 ? parts[i].centre[2] : 0;
    }
    poly->x.count = work->parts.count;
    for (i = 0; x != NULL && i < count && work->job->mesh->dim == 2; i++, at = parts[at].beyond[0]) {
        if (!pbwc__open_facet(memory, poly, (pbw_index)parts[at].link[1])
            || !pbwc__push(memory, &poly->loop, (pbw_index)at)) {
            return 0;
        }
    }
    for (u = 0; x != NULL && u < (int)work->links.count && work->job->mesh->dim == 3; u++) {
        if (!pbwc__open_facet(memory, poly, (pbw_index)u)) {
            return 0;
        }
        at = start = PBWC__LINKS(work)[u].part;
        do {
            if (!pbwc__push(memory, &poly->loop, (pbw_index)at)) {
                return 0;
            }
            at = pbwc__around(parts + at, u, 1);
        } while (at != start);
    }
    return x != NULL;
}

/* The star's polytope cut by the walls of the domain. */
static int pbwc__cut_star(pbwc__work *work, pbw_index v)
{
    const pbwc__job *job = work->job;
    const size_t dim = (size_t)job->mesh->dim;
    const double *site = job->mesh->points + v * dim;
    double plane[4];
    size_t i, k;
    if (!pbwc__star_poly(work)) {
        return 0;
    }
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
    const double *x = PBWC__DOUBLES(poly->x);
    const pbw_index *loop = PBWC__INDICES(poly->loop) + PBWC__INDICES(poly->start)[facet];
    const size_t count = pbwc__loop_end(poly, facet) - PBWC__INDICES(poly->start)[facet];
    double area[3] = { 0, 0, 0 }, across[3], w;
    size_t i;
    int k;
    if (dim == 2) {
        const double *a = x + 3 * loop[0];
        const double *b = x + 3 * PBWC__INDICES(poly->loop)[facet + 1 < poly->loop.count ? facet + 1 : 0];
        w = a[0] * b[1] - a[1] * b[0];
        sum[3] += w;
        sum[0] += w * (a[0] + b[0]);
        sum[1] += w * (a[1] + b[1]);
        return sqrt((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]));
    }
    for (i = 1; i + 1 < count; i++) {
        const double *a = x + 3 * loop[0], *b = x + 3 * loop[i], *c = x + 3 * loop[i + 1];
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
    size_t i, k, begin = PBWC__INDICES(poly->start)[facet], end = pbwc__loop_end(poly, facet) + (dim == 2);
    for (i = begin; i < end; i++) {
        const pbw_index corner = PBWC__INDICES(poly->loop)[i < poly->loop.count ? i : 0];
        if (number[corner] == PBW_NONE) {
            double x[3];
            for (k = 0; k < dim; k++) {
                x[k] = site[k] + PBWC__DOUBLES(poly->x)[3 * corner + k];
            }
            number[corner] = pbwc__push_vector(work, &work->out->vertices, x);
            if (number[corner] == PBW_NONE) {
                return 0;
            }
        }
        if (!pbwc__push(work->memory, &work->out->loops, (pbw_index)simplices + number[corner])) {
            return 0;
        }
    }
    return 1;
}

/* Facets of a cut cell are named by their link or wall. */
static pbw_index pbwc__name_of(const pbwc__work *work, pbw_index name)
{
    return name < work->links.count ? PBWC__LINKS(work)[name].vertex : name;
}

/* The facets of the cut cell.  Where rounding has bent the surface, a plane may have several facets in a row: one
   takes all their areas, with the loop of the largest. */
static int pbwc__cut_facets(pbwc__work *work, pbw_index v)
{
    const pbwc__poly *poly = &work->cutter.poly;
    pbwc__array *numbers = &work->cutter.cap;        /* of corners; the cap is done */
    const pbw_index *name = PBWC__INDICES(poly->name);
    const int dim = work->job->mesh->dim;
    double sum[4] = { 0, 0, 0, 0 };
    size_t i, next;
    numbers->count = 0;
    if (pbwc__room(work->memory, numbers, poly->x.count + 1, sizeof(pbw_index)) == NULL) {
        return 0;
    }
    memset(numbers->data, 0xff, poly->x.count * sizeof(pbw_index));
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
             && !pbwc__cut_loop_out(work, v, best, PBWC__INDICES(*numbers)))
            || !pbwc__facet_done(work, pbwc__name_of(work, name[i]), area, begin)) {
            return 0;
        }
    }
    return 1;
}

/* ------------------------------------------------------------------------------------------------------
   Periodic boxes: the cells of the points in a mesh with copies of them beyond the box's walls.  Copies are exact
   translates, as coordinates and box sizes are made multiples of one power of two per axis.  Enough copies, for
   certain: a copy that is not in the mesh could take from a cell only if it takes one of the cell's corners, so if it
   is in the ball around that corner that reaches to the site (with weights: whose square is the corner's power
   distance plus the largest weight).  Balls that leave the padded box mark a grid, and the copies there are added.
   A cell that becomes smaller has smaller balls, in the union of its old ones; so a second round is the last.
   Along a periodic axis a cell reaches at most half the box from its site, as its images have the rest; so a box of
   3/4 to each side is what it is cut from.
   ------------------------------------------------------------------------------------------------------ */

/* The cell of the grid along axis k. */
static int pbwc__grid_at(const pbwc__period *period, int k, double x)
{
    const double at = (x - period->low[k]) / (period->high[k] - period->low[k]) * PBWC__GRID;
    return !(at > 0) ? 0 : at >= PBWC__GRID ? PBWC__GRID - 1 : (int)at;
}

static unsigned char *pbwc__grid_mark(const pbwc__period *period, const int at[3])
{
    return (unsigned char *)period->marks.data + ((size_t)at[2] * PBWC__GRID + (size_t)at[1]) * PBWC__GRID + at[0];
}

/* Marks what the ball around x covers if it leaves the padded box; square: of its radius, less the largest weight. */
static void pbwc__certify(pbwc__period *period, const double *x, double square)
{
    const double radius = sqrt(square + period->heaviest > 0 ? square + period->heaviest : 0) * (1 + 1e-9);
    int from[3] = { 0, 0, 0 }, to[3] = { 0, 0, 0 }, at[3], k, inside = 1;
    for (k = 0; k < period->dim; k++) {
        const double slack = radius + 1e-12 * (period->high[k] - period->low[k]);
        from[k] = pbwc__grid_at(period, k, x[k] - slack);
        to[k] = pbwc__grid_at(period, k, x[k] + slack);
        if ((period->axes >> k & 1) != 0) {
            inside &= x[k] - slack > -period->margin[k] && x[k] + slack < period->size[k] + period->margin[k];
        }
    }
    for (at[2] = from[2]; !inside && at[2] <= to[2]; at[2]++) {
        for (at[1] = from[1]; at[1] <= to[1]; at[1]++) {
            for (at[0] = from[0]; at[0] <= to[0]; at[0]++) {
                unsigned char *mark = pbwc__grid_mark(period, at);
                if (PBWC__READ(mark) == 0) {         /* threads may write the same */
                    PBWC__WRITE(mark, 1);
                    PBWC__WRITE(&period->marked, 1);
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
        const double *d = PBWC__DOUBLES(poly->x) + 3 * PBWC__INDICES(poly->loop)[i];
        double x[3], square = mesh->weights != NULL ? -mesh->weights[v] : 0;
        for (k = 0; k < dim; k++) {
            x[k] = mesh->points[v * dim + k] + d[k];
            square += d[k] * d[k];
        }
        pbwc__certify(work->job->period, x, square);
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
            read |= corner[k] < job->count && ((const unsigned char *)job->states.data)[corner[k]] == 0;
        }
        if (read) {
            (void)pbwc__centre_of(mesh, (pbw_index)from, x);
            for (k = 0; k < dim; k++) {
                square += x[k] * x[k];
                x[k] += mesh->points[corner[0] * dim + k];
            }
            pbwc__certify(job->period, x, square);
        }
    }
    return PBW_OK;
}

/* ------------------------------------------------------------------------------------------------------
   Ranges of points, each with memory of its own; then their parts in one.
   ------------------------------------------------------------------------------------------------------ */
static int pbwc__cell(pbwc__work *work, pbw_index v)
{
    pbwc__job *job = work->job;
    const size_t before = work->out->neighbors.count;
    const int cut = ((unsigned char *)job->states.data)[v] != 0 && job->bounded;
    double sum[4];
    size_t k;
    if (job->mesh->incident[v] == PBW_NONE || (!cut && (job->what & PBW_CELLS_FACETS) == 0)) {
        return 1;
    }
    if (!pbwc__gather(work, v)) {
        return 0;
    }
    if (cut) {
        if (!(work->open || !work->good ? pbwc__cut_cell(work, v, 0) : pbwc__cut_star(work, v))) {
            return 0;
        }
        memset(sum, 0, sizeof sum);
        for (k = 0; k < work->cutter.poly.start.count; k++) {
            (void)pbwc__sum_facet(&work->cutter.poly, k, job->mesh->dim, sum);
        }
        pbwc__set_cell(job, v, sum);
        if (job->period != NULL) {
            pbwc__certify_cut(work, v);
        }
        if ((job->what & PBW_CELLS_FACETS) != 0
            && ((PBWC__INDICES(job->merged) != NULL && !pbwc__cut_cell(work, v, 1)) || !pbwc__cut_facets(work, v))) {
            return 0;
        }
    } else {
        pbwc__add_areas(work);
        if (!(job->mesh->dim == 3 ? pbwc__star_facets3(work) : pbwc__star_facets2(work))) {
            return 0;
        }
    }
    job->first[v + 1] = work->out->neighbors.count - before;
    return 1;
}

static pbw_status pbwc__cells_range(void *arg, size_t from, size_t to)
{
    pbwc__job *job = (pbwc__job *)arg;
    pbwc__array centres;
    pbwc__work work;
    size_t v;
    int good;
    memset(&work, 0, sizeof work);
    memset(&centres, 0, sizeof centres);
    work.job = job;
    work.memory = &job->memory;
    work.out = (pbwc__range *)job->ranges.data + from / job->grain;
    good = pbwc__centres_new(work.memory, &centres);
    work.centres = (pbwc__centre *)centres.data;
    for (v = from; good && v < to; v++) {
        good = pbwc__cell(&work, (pbw_index)v);
    }
    pbwc__release(work.memory, &centres);
    pbwc__release(work.memory, &work.parts);
    pbwc__release(work.memory, &work.links);
    pbwc__release(work.memory, &work.part_of.slots);
    pbwc__release(work.memory, &work.link_of.slots);
    pbwc__cutter_release(work.memory, &work.cutter);
    return good ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Where a range's items begin in the arrays of all. */
typedef struct pbwc__joining {
    pbwc__job *job;
    size_t *facets, *entries, *vertices, *rays;      /* per range */
    pbw_index *neighbors, *loops;
    double *areas, *all_vertices, *all_rays;
    size_t *loop_first;
} pbwc__joining;

static pbw_status pbwc__join(void *arg, size_t from, size_t to)
{
    const pbwc__joining *joining = (const pbwc__joining *)arg;
    const pbwc__job *job = joining->job;
    const size_t dim = (size_t)job->mesh->dim, simplices = job->mesh->simplex_count;
    size_t r, i;
    for (r = from; r < to; r++) {
        const pbwc__range *range = (const pbwc__range *)job->ranges.data + r;
        const size_t facets = range->neighbors.count, rays = range->rays.count / dim;
        size_t entry = joining->entries[r];
        if (facets > 0) {
            memcpy(joining->neighbors + joining->facets[r], range->neighbors.data, facets * sizeof(pbw_index));
            memcpy(joining->areas + joining->facets[r], range->areas.data, facets * sizeof(double));
        }
        for (i = 0; i < range->loop_counts.count; i++) {
            joining->loop_first[joining->facets[r] + i] = entry;
            entry += PBWC__INDICES(range->loop_counts)[i];
        }
        for (i = 0; i < range->loops.count; i++) {
            pbw_index corner = PBWC__INDICES(range->loops)[i];
            corner = corner >= PBW_NONE - rays ? corner - (pbw_index)(joining->rays[r] / dim)
                   : corner >= simplices ? corner + (pbw_index)(joining->vertices[r] / dim - simplices) : corner;
            joining->loops[joining->entries[r] + i] = corner;
        }
        if (range->vertices.count > 0) {
            memcpy(joining->all_vertices + joining->vertices[r], range->vertices.data,
                   range->vertices.count * sizeof(double));
        }
        if (range->rays.count > 0) {
            memcpy(joining->all_rays + joining->rays[r], range->rays.data, range->rays.count * sizeof(double));
        }
    }
    return PBW_OK;
}

static pbw_status pbwc__all_centres(void *arg, size_t from, size_t to)
{
    const pbwc__joining *joining = (const pbwc__joining *)arg;
    const pbw_mesh *mesh = joining->job->mesh;
    const size_t dim = (size_t)mesh->dim;
    for (; from < to; from++) {
        const double *a = mesh->points + mesh->simplices[from * (dim + 1)] * dim;
        double centre[3];
        size_t k;
        (void)pbwc__centre_of(mesh, (pbw_index)from, centre);
        for (k = 0; k < dim; k++) {
            joining->all_vertices[from * dim + k] = a[k] + centre[k];
        }
    }
    return PBW_OK;
}

/* What pbw_cells.memory points at. */
enum { PBWC__VOLUMES, PBWC__CENTROIDS, PBWC__FIRST, PBWC__NEIGHBORS, PBWC__SHIFTS, PBWC__AREAS, PBWC__VERTICES,
       PBWC__LOOP_FIRST, PBWC__LOOPS, PBWC__RAYS, PBWC__ARRAYS };
typedef struct pbwc__owned {
    pbwc__memory memory;
    pbwc__array array[PBWC__ARRAYS];
} pbwc__owned;

static void pbwc__drop(pbwc__memory *memory, pbw_cells *cells)
{
    pbwc__owned *owned = (pbwc__owned *)cells->memory;
    pbwc__array self = { owned, 0, sizeof *owned };
    int i;
    for (i = 0; i < PBWC__ARRAYS; i++) {
        pbwc__release(memory, owned->array + i);
    }
    pbwc__release(memory, &self);
    memset(cells, 0, sizeof *cells);
}

PBWCELLSDEF void pbw_cells_free(pbw_cells *cells)
{
    if (cells != NULL && cells->memory != NULL) {
        pbwc__memory memory = ((pbwc__owned *)cells->memory)->memory;
        pbwc__drop(&memory, cells);
    }
}

/* An array of the result; at least one byte, so that NULL means: no memory. */
static void *pbwc__own(pbwc__job *job, int which, size_t count, size_t size)
{
    pbwc__owned *owned = (pbwc__owned *)job->cells->memory;
    return pbwc__resize(&job->memory, owned->array + which, count * size + 1) ? owned->array[which].data : NULL;
}

static void pbwc__place_ranges(pbwc__joining *joining, size_t ranges, size_t *sums)
{
    const pbwc__job *job = joining->job;
    size_t r;
    sums[0] = sums[1] = sums[3] = 0;
    sums[2] = (job->what & PBW_CELLS_SHAPES) != 0 ? job->mesh->simplex_count * (size_t)job->mesh->dim : 0;
    for (r = 0; r < ranges; r++) {
        const pbwc__range *range = (const pbwc__range *)job->ranges.data + r;
        joining->facets[r] = sums[0];
        joining->entries[r] = sums[1];
        joining->vertices[r] = sums[2];
        joining->rays[r] = sums[3];
        sums[0] += range->neighbors.count;
        sums[1] += range->loops.count;
        sums[2] += range->vertices.count;
        sums[3] += range->rays.count;
    }
}

/* Facets and shapes of all ranges, one after the other. */
static pbw_status pbwc__join_all(pbwc__job *job, size_t ranges, const pbw_options *options)
{
    const size_t dim = (size_t)job->mesh->dim;
    const int shapes = (job->what & PBW_CELLS_SHAPES) != 0;
    pbw_cells *cells = job->cells;
    pbwc__array places;
    pbwc__joining joining;
    size_t sums[4], v;
    pbw_status status = PBW_OK;
    memset(&places, 0, sizeof places);
    memset(&joining, 0, sizeof joining);
    if (!pbwc__resize(&job->memory, &places, (4 * ranges + 1) * sizeof(size_t))) {
        return PBW_ERROR_MEMORY;
    }
    joining.job = job;
    joining.facets = (size_t *)places.data;
    joining.entries = joining.facets + ranges;
    joining.vertices = joining.entries + ranges;
    joining.rays = joining.vertices + ranges;
    pbwc__place_ranges(&joining, ranges, sums);
    cells->neighbors = joining.neighbors = (pbw_index *)pbwc__own(job, PBWC__NEIGHBORS, sums[0], sizeof(pbw_index));
    cells->areas = joining.areas = (double *)pbwc__own(job, PBWC__AREAS, sums[0], sizeof(double));
    if (shapes) {
        joining.loop_first = (size_t *)pbwc__own(job, PBWC__LOOP_FIRST, sums[0] + 1, sizeof(size_t));
        cells->loop_first = joining.loop_first;
        cells->loops = joining.loops = (pbw_index *)pbwc__own(job, PBWC__LOOPS, sums[1], sizeof(pbw_index));
        cells->vertices = joining.all_vertices = (double *)pbwc__own(job, PBWC__VERTICES, sums[2], sizeof(double));
        cells->rays = joining.all_rays = (double *)pbwc__own(job, PBWC__RAYS, sums[3], sizeof(double));
    }
    if (joining.neighbors == NULL || joining.areas == NULL
        || (shapes && (joining.loop_first == NULL || joining.loops == NULL || joining.all_vertices == NULL
                       || joining.all_rays == NULL))) {
        status = PBW_ERROR_MEMORY;
    } else if (sums[2] / dim + sums[3] / dim >= PBW_NONE) {
        status = PBW_ERROR_TOO_LARGE;
    }
    if (status == PBW_OK && shapes) {
        joining.loop_first[sums[0]] = sums[1];
        status = pbw_for(options, job->mesh->simplex_count, 8192, pbwc__all_centres, &joining);
    }
    if (status == PBW_OK) {
        status = pbw_for(options, ranges, 1, pbwc__join, &joining);
    }
    for (v = 0; v < cells->cell_count; v++) {
        job->first[v + 1] += job->first[v];
    }
    cells->facet_count = sums[0];
    cells->vertex_count = sums[2] / dim;
    cells->ray_count = sums[3] / dim;
    pbwc__release(&job->memory, &places);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   Merging: two simplices that share a facet have one centre if and only if the far corner of either lies exactly on
   the sphere of the other.  merged[s] is the first simplex that is connected to s by such facets.
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

static pbw_index pbwc__root(pbw_index *merged, pbw_index s)
{
    while (merged[s] != s) {
        merged[s] = merged[merged[s]];
        s = merged[s];
    }
    return s;
}

static pbw_status pbwc__merge(pbwc__job *job, const pbw_options *options)
{
    const pbw_mesh *mesh = job->mesh;
    const size_t count = mesh->simplex_count, corners = (size_t)mesh->dim + 1;
    pbwc__array tied;
    pbwc__ties ties;
    pbw_index *merged;
    size_t s, i;
    pbw_status status;
    memset(&tied, 0, sizeof tied);
    if (!pbwc__resize(&job->memory, &job->merged, (count + 1) * sizeof(pbw_index))
        || !pbwc__resize(&job->memory, &tied, count + 1)) {
        pbwc__release(&job->memory, &tied);
        return PBW_ERROR_MEMORY;
    }
    ties.mesh = mesh;
    ties.tied = (unsigned char *)tied.data;
    status = pbw_for(options, count, 4096, pbwc__find_ties, &ties);
    merged = PBWC__INDICES(job->merged);
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
    pbwc__release(&job->memory, &tied);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   The domain as a polytope and as planes.
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
        const double *x = PBWC__DOUBLES(job->domain.x) + 3 * PBWC__INDICES(job->domain.loop)[i];
        for (k = 0; k < dim; k++) {
            low[k] = i == 0 || x[k] < low[k] ? x[k] : low[k];
            high[k] = i == 0 || x[k] > high[k] ? x[k] : high[k];
        }
    }
    for (i = 0; i < job->domain.name.count; i++) {
        walls |= PBWC__INDICES(job->domain.name)[i] > PBW_NONE - 1 - 2 * dim;
    }
    return walls;
}

/* A domain of planes alone: cut from a box so large that a wall left of it means an unbounded domain, then again from
   a box that fits, so that the corners are as exact as they can be. */
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
    double low[3], high[3];
    size_t i, k;
    pbw_status status = PBW_OK;
    for (k = 0; k < 3; k++) {
        job->low[k] = -HUGE_VAL;
        job->high[k] = HUGE_VAL;
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
        job->extent[k] = high[k] - low[k];
    }
    return status == PBW_OK ? pbwc__cut_domain(job, domain, low, high) : status;
}

/* ------------------------------------------------------------------------------------------------------
   The call.
   ------------------------------------------------------------------------------------------------------ */
static pbw_status pbwc__compute(pbwc__job *job, const pbw_domain *domain, const pbw_options *options)
{
    const size_t count = job->cells->cell_count, dim = (size_t)job->mesh->dim;
    size_t ranges, r;
    pbw_status status = pbwc__prepare_domain(job, domain);
    job->grain = 2048;
    ranges = (count + job->grain - 1) / job->grain;
    job->volumes = (double *)pbwc__own(job, PBWC__VOLUMES, count, sizeof(double));
    job->centroids = (double *)pbwc__own(job, PBWC__CENTROIDS, count * dim, sizeof(double));
    job->first = (size_t *)pbwc__own(job, PBWC__FIRST, count + 1, sizeof(size_t));
    job->cells->volumes = job->volumes;
    job->cells->centroids = job->centroids;
    job->cells->first = job->first;
    if (status == PBW_OK && (job->volumes == NULL || job->centroids == NULL || job->first == NULL
                             || !pbwc__resize(&job->memory, &job->ranges, (ranges + 1) * sizeof(pbwc__range)))) {
        status = PBW_ERROR_MEMORY;
    }
    if (status != PBW_OK) {
        return status;
    }
    memset(job->first, 0, (count + 1) * sizeof(size_t));
    memset(job->ranges.data, 0, job->ranges.bytes);
    if ((job->what & PBW_CELLS_MERGE) != 0) {
        status = pbwc__merge(job, options);
    }
    if (status == PBW_OK) {
        status = pbwc__add_up(job, options);
    }
    if (status == PBW_OK && (job->bounded || (job->what & PBW_CELLS_FACETS) != 0)) {
        status = pbw_for(options, count, job->grain, pbwc__cells_range, job);
    }
    if (status == PBW_OK && job->period != NULL) {
        status = pbw_for(options, job->mesh->simplex_count, PBWC__CHUNK, pbwc__certify_simplices, job);
    }
    if (status == PBW_OK && (job->what & PBW_CELLS_FACETS) != 0) {
        status = pbwc__join_all(job, ranges, options);
    }
    for (r = 0; r < ranges; r++) {
        pbwc__range *range = (pbwc__range *)job->ranges.data + r;
        pbwc__release(&job->memory, &range->neighbors);
        pbwc__release(&job->memory, &range->areas);
        pbwc__release(&job->memory, &range->loop_counts);
        pbwc__release(&job->memory, &range->loops);
        pbwc__release(&job->memory, &range->vertices);
        pbwc__release(&job->memory, &range->rays);
    }
    return status;
}

static int pbwc__knows(unsigned what)
{
    return (what & ~(PBW_CELLS_FACETS | PBW_CELLS_SHAPES | PBW_CELLS_MERGE)) == 0;
}

static void pbwc__job_start(pbwc__job *job, unsigned what, const pbw_options *options)
{
    memset(job, 0, sizeof *job);
    job->what = what | ((what & PBW_CELLS_SHAPES) != 0 ? PBW_CELLS_FACETS : 0);
    job->memory.resize = options != NULL && options->resize != NULL ? options->resize : pbwc__default_resize;
    job->memory.user = options != NULL ? options->resize_user : NULL;
    job->memory.limit = options != NULL ? options->memory_limit : 0;
}

/* Fills job->cells, with the mesh, the count, what and the memory of the job.  Leaves them empty if it fails. */
static pbw_status pbwc__run(pbwc__job *job, const pbw_domain *domain, const pbw_options *options)
{
    pbw_cells *cells = job->cells;
    pbwc__array self;
    pbw_status status;
    memset(&self, 0, sizeof self);
    if (!pbwc__resize(&job->memory, &self, sizeof(pbwc__owned))) {
        return PBW_ERROR_MEMORY;
    }
    memset(self.data, 0, self.bytes);
    cells->dim = job->mesh->dim;
    cells->cell_count = job->count;
    cells->memory = self.data;
    status = pbwc__compute(job, domain, options);
    if (status == PBW_OK && (job->what & PBW_CELLS_FACETS) == 0) {
        pbwc__release(&job->memory, ((pbwc__owned *)cells->memory)->array + PBWC__FIRST);
        cells->first = NULL;
    }
    pbwc__poly_release(&job->memory, &job->domain);
    pbwc__release(&job->memory, &job->merged);
    pbwc__release(&job->memory, &job->ranges);
    pbwc__release(&job->memory, &job->states);
    ((pbwc__owned *)cells->memory)->memory = job->memory;
    if (status != PBW_OK) {
        pbwc__drop(&job->memory, job->cells);
    }
    return status;
}

PBWCELLSDEF pbw_status pbw_cells_of(const pbw_mesh *mesh, const pbw_domain *domain, unsigned what,
                                    const pbw_options *options, pbw_cells *cells)
{
    pbwc__job job;
    pbw_status status;
    if (cells == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(cells, 0, sizeof *cells);
    if (mesh == NULL || (mesh->dim != 2 && mesh->dim != 3) || (mesh->simplex_count > 0 && mesh->neighbors == NULL)
        || !pbwc__knows(what)
        || (domain != NULL && (domain->periodic != 0 || (domain->plane_count > 0 && domain->planes == NULL)))) {
        return PBW_ERROR_ARGUMENT;
    }
    pbwc__job_start(&job, what, options);
    job.mesh = mesh;
    job.count = mesh->point_count;
    job.cells = cells;
    status = pbwc__run(&job, domain, options);
    return status == PBW_OK && mesh->simplex_count == 0 ? PBW_DEGENERATE : status;
}

/* Sizes and points in the units, in [0, size) along periodic axes. */
static pbw_status pbwc__snap(pbwc__period *period, const double *points, const double *weights, const double *box)
{
    const size_t dim = (size_t)period->dim;
    double *x = PBWC__DOUBLES(period->x), *w = PBWC__DOUBLES(period->w);
    size_t i, k;
    for (i = 0; i < period->count * dim; i++) {
        k = i % dim;
        x[i] = points[i] + 0.0;
        if (!(fabs(x[i]) < HUGE_VAL)) {
            return PBW_ERROR_NOT_FINITE;
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
        const double spacing = pow(volume / (double)(period->count > 0 ? period->count : 1), 1.0 / (double)dim);
        double reach = longest / period->size[k];
        int exponent;
        (void)frexp(period->size[k], &exponent);
        for (exponent -= 51; reach > 1; reach /= 2) {
            exponent++;
        }
        period->unit[k] = ldexp(1, exponent + 3);
        period->size[k] = floor(period->size[k] / period->unit[k] + 0.5) * period->unit[k];
        period->margin[k] = 3.2 * spacing < period->size[k] ? 3.2 * spacing : period->size[k];
    }
    return PBW_OK;
}

/* The grid: where balls of cells can reach. */
static pbw_status pbwc__reach(pbwc__period *period)
{
    double square = period->heaviest - period->lightest, radius;
    int k;
    for (k = 0; k < period->dim; k++) {
        const double half = (period->high[k] - period->low[k]) * ((period->axes >> k & 1) != 0 ? 0.75 : 1);
        square += half * half;
    }
    radius = 1.001 * sqrt(square);
    for (k = 0; k < period->dim; k++) {
        if ((period->axes >> k & 1) != 0) {
            period->low[k] = -0.75 * period->size[k] - radius;
            period->high[k] = 1.75 * period->size[k] + radius;
            if (period->high[k] > 4e15 * period->unit[k]) {      /* copies would not be exact */
                return PBW_ERROR_ARGUMENT;
            }
        }
    }
    if (!pbwc__resize(period->memory, &period->marks, (size_t)PBWC__GRID * PBWC__GRID * PBWC__GRID)) {
        return PBW_ERROR_MEMORY;
    }
    memset(period->marks.data, 0, period->marks.bytes);
    return PBW_OK;
}

/* Where copies may be: the padded box and all marks. */
static void pbwc__extent(pbwc__period *period)
{
    const double step = 1.0 / PBWC__GRID;
    int at[3], k;
    for (k = 0; k < period->dim; k++) {
        period->from[k] = -period->margin[k];
        period->to[k] = period->size[k] + period->margin[k];
    }
    for (at[2] = 0; at[2] < PBWC__GRID; at[2]++) {
        for (at[1] = 0; at[1] < PBWC__GRID; at[1]++) {
            for (at[0] = 0; at[0] < PBWC__GRID; at[0]++) {
                for (k = 0; *pbwc__grid_mark(period, at) != 0 && k < period->dim; k++) {
                    const double size = period->high[k] - period->low[k];
                    const double low = period->low[k] + size * step * (at[k] - 0.01);
                    const double high = period->low[k] + size * step * (at[k] + 1.01);
                    period->from[k] = low < period->from[k] ? low : period->from[k];
                    period->to[k] = high > period->to[k] ? high : period->to[k];
                }
            }
        }
    }
}

static int pbwc__is_copied(const pbwc__period *period, const double *x)
{
    int at[3] = { 0, 0, 0 }, k, inside = 1;
    for (k = 0; k < period->dim; k++) {
        at[k] = pbwc__grid_at(period, k, x[k]);
        if ((period->axes >> k & 1) != 0) {
            inside &= x[k] >= -period->margin[k] && x[k] <= period->size[k] + period->margin[k];
        }
    }
    return inside || *pbwc__grid_mark(period, at) != 0;
}

/* One more point.  Returns 0 if there is no memory. */
static int pbwc__add_copy(pbwc__period *period, const double *x, double weight, pbw_index source)
{
    const size_t dim = (size_t)period->dim;
    double *place, *w;
    period->x.count = period->total * dim;
    period->w.count = period->total;
    place = (double *)pbwc__room(period->memory, &period->x, dim, sizeof(double));
    w = (double *)pbwc__room(period->memory, &period->w, 1, sizeof(double));
    if (place == NULL || w == NULL || !pbwc__push(period->memory, &period->source, source)) {
        return 0;
    }
    memcpy(place, x, dim * sizeof(double));
    *w = weight;
    period->total++;
    return 1;
}

static int pbwc__add_copies(pbwc__period *period, size_t i)
{
    const size_t dim = (size_t)period->dim;
    const double weight = PBWC__DOUBLES(period->w)[i];
    double p[3], x[3], first[3] = { 0, 0, 0 }, last[3] = { 0, 0, 0 }, shift[3];
    size_t k;
    for (k = 0; k < dim; k++) {
        p[k] = x[k] = PBWC__DOUBLES(period->x)[i * dim + k];
        if ((period->axes >> k & 1) != 0) {
            first[k] = ceil((period->from[k] - p[k]) / period->size[k]);
            last[k] = floor((period->to[k] - p[k]) / period->size[k]);
        }
    }
    for (shift[2] = first[2]; shift[2] <= last[2]; shift[2]++) {
        for (shift[1] = first[1]; shift[1] <= last[1]; shift[1]++) {
            for (shift[0] = first[0]; shift[0] <= last[0]; shift[0]++) {
                if (shift[0] == 0 && shift[1] == 0 && shift[2] == 0) {
                    continue;
                }
                for (k = 0; k < dim; k++) {
                    x[k] = p[k] + shift[k] * period->size[k];
                }
                if (pbwc__is_copied(period, x) && !pbwc__add_copy(period, x, weight, (pbw_index)i)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* All points with their copies, and the apexes of a simplex so large that no cell of theirs meets the grid. */
static pbw_status pbwc__copies(pbwc__period *period)
{
    static const signed char corner[4][3] = { { 1, 1, 1 }, { -1, -1, 1 }, { -1, 1, -1 }, { 1, -1, -1 } };
    double far_out = 0, x[3];
    size_t i;
    int k;
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
    for (k = 0; k < period->dim; k++) {
        far_out += 8 * (period->high[k] - period->low[k]);
    }
    for (i = 0; period->apexes && i <= (size_t)period->dim; i++) {
        for (k = 0; k < period->dim; k++) {
            x[k] = period->low[k] + corner[i][k] * far_out;
        }
        if (!pbwc__add_copy(period, x, period->lightest, 0)) {
            return PBW_ERROR_MEMORY;
        }
    }
    return PBW_OK;
}

/* Names copies by their points and shifts, and moves all back to where the box is. */
static pbw_status pbwc__unwrap(pbwc__job *job, const double *box)
{
    const pbwc__period *period = job->period;
    const size_t dim = (size_t)period->dim, facets = job->cells->facet_count;
    pbwc__owned *owned = (pbwc__owned *)job->cells->memory;
    pbw_index *neighbors = PBWC__INDICES(owned->array[PBWC__NEIGHBORS]);
    double *vertices = PBWC__DOUBLES(owned->array[PBWC__VERTICES]);
    const double *x = PBWC__DOUBLES(period->x);
    size_t i, k;
    for (i = 0; i < period->count * dim; i++) {
        job->centroids[i] += (period->axes >> i % dim & 1) != 0 ? box[i % dim] : 0;
    }
    for (i = 0; i < job->cells->vertex_count * dim; i++) {
        vertices[i] += (period->axes >> i % dim & 1) != 0 ? box[i % dim] : 0;
    }
    if ((job->what & PBW_CELLS_FACETS) != 0) {
        signed char *shifts = (signed char *)pbwc__own(job, PBWC__SHIFTS, facets * dim, 1);
        job->cells->shifts = shifts;
        if (shifts == NULL) {
            return PBW_ERROR_MEMORY;
        }
        memset(shifts, 0, facets * dim);
        for (i = 0; i < facets; i++) {
            const size_t copy = neighbors[i];
            if (copy >= period->count && copy < period->total) {
                neighbors[i] = PBWC__INDICES(period->source)[copy - period->count];
                for (k = 0; k < dim; k++) {
                    const double shift = (x[copy * dim + k] - x[neighbors[i] * dim + k]) / period->size[k];
                    shifts[i * dim + k] = (signed char)((period->axes >> k & 1) == 0 ? 0 : shift);
                }
            }
        }
    }
    return PBW_OK;
}

/* One round: the mesh of points and copies, and its cells; period->marked tells if more copies are needed. */
static pbw_status pbwc__round(pbwc__job *job, const double *box, const pbw_options *options)
{
    pbwc__period *period = job->period;
    pbw_options own;
    pbw_domain domain;
    pbw_mesh mesh;
    double walls[6];
    const size_t dim = (size_t)period->dim;
    size_t k;
    pbw_status status = pbwc__copies(period);
    memset(&own, 0, sizeof own);
    memset(&domain, 0, sizeof domain);
    memset(&mesh, 0, sizeof mesh);
    if (options != NULL) {
        own = *options;
    }
    own.stride = own.weight_stride = 0;
    own.flags = PBW_BORROW;
    own.trace = NULL;
    if (status == PBW_OK) {
        const double *weights = job->weighted ? PBWC__DOUBLES(period->w) : NULL;
        status = pbw_triangulate(period->dim, PBWC__DOUBLES(period->x), weights, period->total, &own, &mesh);
    }
    if (status == PBW_DEGENERATE && period->count > 0) {
        period->apexes = period->marked = 1;
        status = PBW_OK;
    } else if (status == PBW_OK || status == PBW_DEGENERATE) {
        for (k = 0; k < dim; k++) {
            walls[k] = (period->axes >> k & 1) != 0 ? -0.75 * period->size[k] : box[k];
            walls[dim + k] = (period->axes >> k & 1) != 0 ? 0.75 * period->size[k] : box[dim + k];
        }
        domain.box = walls;
        job->mesh = &mesh;
        status = pbwc__run(job, &domain, options);
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

PBWCELLSDEF pbw_status pbw_cells_periodic(int dim, const double *points, const double *weights, size_t count,
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
    if ((dim != 2 && dim != 3) || (points == NULL && count > 0) || domain == NULL || domain->box == NULL
        || domain->plane_count != 0 || domain->periodic == 0 || domain->periodic >> dim != 0 || !pbwc__knows(what)
        || (options != NULL && (options->stride != 0 || options->weight_stride != 0))) {
        return PBW_ERROR_ARGUMENT;
    }
    if (count >= PBW_NONE / 2) {
        return PBW_ERROR_TOO_LARGE;
    }
    memset(&period, 0, sizeof period);
    pbwc__job_start(&job, what, options);
    period.dim = dim;
    period.axes = domain->periodic;
    period.count = count;
    period.memory = &job.memory;
    job.period = &period;
    job.count = count;
    job.cells = cells;
    job.weighted = weights != NULL;
    status = pbwc__resize(&job.memory, &period.x, count * (size_t)dim * sizeof(double) + 1)
             && pbwc__resize(&job.memory, &period.w, count * sizeof(double) + 1) ? PBW_OK : PBW_ERROR_MEMORY;
    if (status == PBW_OK) {
        memset(period.w.data, 0, period.w.bytes);
        status = pbwc__units(&period, domain->box);
    }
    status = status == PBW_OK ? pbwc__snap(&period, points, weights, domain->box) : status;
    status = status == PBW_OK ? pbwc__reach(&period) : status;
    do {
        period.marked = 0;
        status = status == PBW_OK ? pbwc__round(&job, domain->box, options) : status;
    } while (status == PBW_OK && period.marked);
    pbwc__release(&job.memory, &period.x);
    pbwc__release(&job.memory, &period.w);
    pbwc__release(&job.memory, &period.source);
    pbwc__release(&job.memory, &period.marks);
    if (cells->memory != NULL) {
        ((pbwc__owned *)cells->memory)->memory = job.memory;
    }
    return status;
}

#endif /* PBW_CELLS_IMPLEMENTATION */
