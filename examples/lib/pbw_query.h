/* pbw_query.h - v0.2.0 - which simplex contains a point, nearest vertices, interpolation - MIT-0

   QUICK START
   In the source file that defines PBW_IMPLEMENTATION, define PBW_QUERY_IMPLEMENTATION too; in others just include.

       #define PBW_IMPLEMENTATION
       #define PBW_QUERY_IMPLEMENTATION
       #include "pbw_query.h"
       #include <stdio.h>

       int main(void) {
           double points[] = { 0,0,  4,0,  0,4,  4,4,  1,2 }, queries[] = { 3,1,  1,3 };
           pbw_index triangle[2], nearest[2];
           static pbw_mesh mesh;
           pbw_status status = pbw_triangulate(2, points, NULL, 5, NULL, &mesh);
           if (status == PBW_OK) status = pbw_locate(&mesh, queries, 2, NULL, triangle, NULL);
           if (status == PBW_OK) status = pbw_nearest(&mesh, NULL, queries, 2, 1, NULL, nearest, NULL);
           if (status != PBW_OK) { printf("%s\n", pbw_status_string(status)); return 1; }
           for (int i = 0; i < 2; i++) printf("in triangle %u, nearest to point %u\n", triangle[i], nearest[i]);
           pbw_free(&mesh);
           return 0;
       }

   Build:  cc -O2 quickstart.c -lpthread

   FUNCTIONS
     pbw_lists_free     frees lists
     pbw_stars          the simplices around each vertex
     pbw_locate_one     the simplex that contains a point, by a walk
     pbw_locate         those of many points
     pbw_finder_create  what finds places for walks to start
     pbw_finder_locate  the simplex that contains a point, by it
     pbw_finder_free    frees it
     pbw_nearest        the nearest vertices of many points
     pbw_within         the vertices in a ball around each of many points
     pbw_coordinates    barycentric, Sibson's or Laplace's weights of many points

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>query        which simplex contains a point
     >>batch        many queries: sorting, blocks, location, lists
     >>finder       where walks of single queries start: nested grids
     >>distance     distances from a query, in exact order
     >>nearest      stars, nearest vertices, vertices in a ball
     >>boxes        many nearest vertices, by a tree of boxes
     >>centres      vectors, pairs, centres of simplices
     >>interpolate  barycentric, Sibson's and Laplace's weights

   PROMISES  (and the test that guards each)
     exact       answers by the true signs of all decisions, for every finite double        tests/test_query.c
     one answer  the same for any number of threads                                         tests/test_query.c
     the others  of pbw.h: never exits, re-entrant, bounded                                 tests/test_contract.c

   Words are those of pbw.h's GLOSSARY and CONVENTIONS.

   CONFIGURATION MACROS
     PBW_QUERY_IMPLEMENTATION   in the source file that has PBW_IMPLEMENTATION: compile the implementation there
     and those of pbw.h: PBW_STATIC and PBWDEF, PBW_NO_SIMD, PBW_NO_THREADS, PBW_WIDE
*/
#ifndef PBW_QUERY_H
#define PBW_QUERY_H
/* ------------------------------------------------------------------------------------------------------
   >>interface
   ------------------------------------------------------------------------------------------------------ */
#include "pbw.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- queries, on a finished mesh with neighbors, which they only read: any number of threads may query it at once.
   Batches are sorted inside along the Hilbert curve and answered by all threads; the answers do not depend on their
   number.  options: threads, stride of the query points, memory_limit, resize, run, progress.
   If a query point is not finite, the status is PBW_ERROR_NOT_FINITE and no query is answered.  On any status but
   PBW_OK the caller's arrays hold undefined values, and lists are empty.  In a mesh of PBW_DEGENERATE points every
   query point lies outside of the hull, stars are empty, and all canonical points count as vertices.  Where points of
   a mesh with PBW_BORROW have moved, answers are undefined; a batch may also end with PBW_ERROR_ARGUMENT. */
typedef struct pbw_lists {                 /* list i: items first[i] .. first[i+1]-1; pbw_lists_free when done */
    size_t count;                          /* of lists */
    const size_t *first;                   /* count+1 */
    const pbw_index *item;
    const double *value;                   /* one for each item, or NULL */
    void *memory;                          /* private */
} pbw_lists;

/* Frees what lists hold and zeroes them; fine on {0}, fine twice. */
PBWDEF void pbw_lists_free(pbw_lists *lists);

/* The neighbours of each point, a list for each; empty for a point that is no vertex.  They come in the order in
   which a walk round the point, from simplex to simplex and starting from mesh->incident, meets them. */
PBWDEF pbw_status pbw_stars(const pbw_mesh *mesh, const pbw_options *options, pbw_lists *stars);

/* Returns the simplex that contains the point (dim coordinates): of those that do, boundaries included, the one of
   the lowest index.  PBW_NONE if the point is outside of the hull, or not finite.
   hull_facet (may be NULL) gets (dim+1)*simplex + corner: the facet opposite to that corner is on the hull, and the
   point on its outer side.  It gets PBW_NONE if there is none: for a point in a simplex, one that is not finite, and
   a mesh without simplices; and where that number does not fit, beyond 1.07e9 simplices (2D: 1.43e9) with PBW_WIDE.
   hint: a simplex to start from; any number will do, and a near simplex is quick.  No allocation. */
PBWDEF pbw_index pbw_locate_one(const pbw_mesh *mesh, const double *point, pbw_index hint, pbw_index *hull_facet);
/* pbw_locate_one for many points; simplices and hull_facets (may be NULL) get an entry for each.  Where several
   facets have the point on their outer side, the other queries of the batch decide which one is named. */
PBWDEF pbw_status pbw_locate(const pbw_mesh *mesh, const double *points, size_t count, const pbw_options *options,
                             pbw_index *simplices, pbw_index *hull_facets);

/* For single queries in any order: grids of simplices to start from, finer where there are more points, one to five
   bytes a point.  Refers to the mesh, which must outlive it.  Locating changes nothing: any number of threads may.
   create: on any status but PBW_OK *finder is NULL.  locate: as pbw_locate_one. */
typedef struct pbw_finder pbw_finder;
PBWDEF pbw_status pbw_finder_create(const pbw_mesh *mesh, const pbw_options *options, pbw_finder **finder);
PBWDEF pbw_index pbw_finder_locate(const pbw_finder *finder, const double *point, pbw_index *hull_facet);
PBWDEF void pbw_finder_free(pbw_finder *finder);           /* fine on NULL */

/* The k nearest vertices of each query point, the nearest first, equally near ones by index: k entries for each of
   vertices and distances (may be NULL).  Where there are fewer: PBW_NONE and HUGE_VAL.  The order is exact, distances
   are rounded.  With weights the distance is the power distance.  stars: of pbw_stars, or NULL to have them made.
   A mesh without simplices takes time in proportion to its points for each query. */
PBWDEF pbw_status pbw_nearest(const pbw_mesh *mesh, const pbw_lists *stars, const double *points, size_t count,
                              size_t k, const pbw_options *options, pbw_index *vertices, double *distances);
/* The vertices not farther than the radius, exactly: a list for each query point, in the order of pbw_nearest, with
   distances as values.  With weights: those of a power distance of at most radius^2. */
PBWDEF pbw_status pbw_within(const pbw_mesh *mesh, const pbw_lists *stars, const double *points, size_t count,
                             double radius, const pbw_options *options, pbw_lists *lists);

typedef enum pbw_scheme { PBW_BARYCENTRIC, PBW_SIBSON, PBW_LAPLACE } pbw_scheme;
/* Generalised barycentric coordinates of each query point: a list of vertices, in the order of their indices, and
   their weights, which are not negative, sum to 1, and have the point as the weighted mean of the vertices.
   PBW_BARYCENTRIC: of the simplex that contains it.  PBW_SIBSON: the share that its Voronoi cell would take from the
   cells of its neighbours; PBW_LAPLACE: the facets of its cell over the distances of the neighbours.  With weights,
   cells are power cells, and the query has the weight 0.  Outside of the hull a list is empty.  On the boundary of
   the hull, where the query would be a hidden point, and where differences of coordinates overflow, all schemes give
   barycentric coordinates. */
PBWDEF pbw_status pbw_coordinates(const pbw_mesh *mesh, const double *points, size_t count, pbw_scheme scheme,
                                  const pbw_options *options, pbw_lists *lists);

#ifdef __cplusplus
}
#endif
#endif /* PBW_QUERY_H */

/* Interface ends here; what follows is for those who want to know how it works. */

#if defined(PBW_QUERY_IMPLEMENTATION) && !defined(PBWQ__IMPLEMENTED)
#define PBWQ__IMPLEMENTED
#if PBW__SEAM != 1
#error "pbw_query.h is compiled where pbw.h of its version is: define PBW_IMPLEMENTATION too, above the include"
#else

PBW__SEAM_BEGIN
/* ------------------------------------------------------------------------------------------------------
   >>query        Which simplex contains a point.
   In: a finished mesh with neighbors, a finite point.  Out: the lowest simplex that contains it, or a hull facet that
   has it on the outer side.
   Holds: the mesh is only read; all decisions are by exact signs.

   A walk steps from simplex to simplex through the facet that has the query most clearly on its outer side, always by
   an exactly negative sign.  It cannot come back to a simplex: in front of the query the simplices of a regular
   triangulation are acyclic (Edelsbrunner 1990, "An acyclicity theorem for cell complexes in d dimensions").  It ends
   outside, or in a simplex that contains the query; signs that are 0 say which others do, and the lowest index wins.
   ------------------------------------------------------------------------------------------------------ */
#define PBWQ__INSIDE 4u                               /* no corner to leave a simplex by */
#define PBWQ__MOVED 5u                               /* a walk came back, or to a flat simplex: points have moved */

/* Finds, by exact signs, a facet that has p strictly on its outer side, and returns the corner opposite to it.
   Returns PBWQ__INSIDE if there is none; *on is then the set of corners with p on the opposite facet.  All of them:
   the simplex is flat, PBWQ__MOVED. */
static PBW__NOINLINE unsigned pbwq__side_exact(const pbw_mesh *mesh, const pbw_index *v, const double *p,
                                               const pbw__grid *grid, unsigned *on)
{
    const size_t dim = (size_t)mesh->dim;
    const double *x[4];
    unsigned i;
    for (i = 0; i <= dim; i++) {
        x[i] = mesh->points + v[i] * dim;
    }
    *on = 0;
    for (i = 0; i <= dim; i++) {
        const int sign = pbw__side(mesh->dim, x, (int)i, p, grid);
        if (sign < 0) {
            return i;
        }
        *on |= (unsigned)(sign == 0) << i;
    }
    return *on == (2u << dim) - 1 ? PBWQ__MOVED : PBWQ__INSIDE;
}

/* Computes side[i], the orientation of the simplex with corner i replaced by p.  Returns a bound for the error of
   each: that of orient3 in >>predicates, as the determinants and roundings are the same.  It is infinite outside of
   the range of pbw__certain, as after an overflow. */
PBW__INLINE double pbwq__sides3(const double *points, const pbw_index *v, const double *p, double *side)
{
    double x[4], y[4], z[4], mx, my, mz, low, high, s01, s02, s03, s12, s13, s23;
    int i;
    for (i = 0; i < 4; i++) {
        const double *q = points + (size_t)v[i] * 3;
        x[i] = q[0] - p[0];
        y[i] = q[1] - p[1];
        z[i] = q[2] - p[2];
    }
    mx = pbw__max_abs(x[0], x[1], x[2], x[3]);
    my = pbw__max_abs(y[0], y[1], y[2], y[3]);
    mz = pbw__max_abs(z[0], z[1], z[2], z[3]);
    s01 = x[0] * y[1] - x[1] * y[0];
    s02 = x[0] * y[2] - x[2] * y[0];
    s03 = x[0] * y[3] - x[3] * y[0];
    s12 = x[1] * y[2] - x[2] * y[1];
    s13 = x[1] * y[3] - x[3] * y[1];
    s23 = x[2] * y[3] - x[3] * y[2];
    side[0] = z[1] * s23 - z[2] * s13 + z[3] * s12;
    side[1] = z[2] * s03 - z[0] * s23 - z[3] * s02;
    side[2] = z[0] * s13 - z[1] * s03 + z[3] * s01;
    side[3] = z[1] * s02 - z[0] * s12 - z[2] * s01;
    low = mx < my ? mx : my;
    low = low < mz ? low : mz;
    high = pbw__max(pbw__max(mx, my), mz);
    return low > 1e-50 && high < 1e100 ? PBW__FILTER_ORIENT3_ERROR * DBL_EPSILON * mx * my * mz : HUGE_VAL;
}

/* pbwq__sides3 in the plane, with the bound of orient2. */
PBW__INLINE double pbwq__sides2(const double *points, const pbw_index *v, const double *p, double *side)
{
    double x[3], y[3], mx, my, low, high;
    int i;
    for (i = 0; i < 3; i++) {
        const double *q = points + (size_t)v[i] * 2;
        x[i] = q[0] - p[0];
        y[i] = q[1] - p[1];
    }
    mx = pbw__max_abs(x[0], x[1], x[2], x[2]);
    my = pbw__max_abs(y[0], y[1], y[2], y[2]);
    side[0] = x[1] * y[2] - x[2] * y[1];
    side[1] = x[2] * y[0] - x[0] * y[2];
    side[2] = x[0] * y[1] - x[1] * y[0];
    low = mx < my ? mx : my;
    high = pbw__max(mx, my);
    return low > 1e-50 && high < 1e100 ? PBW__FILTER_ORIENT2_ERROR * DBL_EPSILON * mx * my : HUGE_VAL;
}

/* Where a walk ends. */
typedef struct pbwq__location {
    size_t simplex, steps;                           /* more steps than simplices: no triangulation has such a walk;
                                                        there may be one where borrowed points have moved */
    unsigned leave;                                  /* PBWQ__INSIDE, PBWQ__MOVED, or the corner opposite to a hull
                                                        facet that has the query on the outer side */
    unsigned on;                                     /* if inside: the corners with the query on the opposite facet */
} pbwq__location;

/* Makes one step of a walk to p: from location->simplex through the facet with the least orientation, if that is
   certainly negative; if it is certainly positive p is inside; otherwise exact signs decide.  Returns whether it is
   not the end of the walk. */
PBW__INLINE int pbwq__step(const pbw_mesh *mesh, pbwq__location *location, const double *p, const pbw__grid *grid,
                           int dim)
{
    const size_t at = location->simplex * (size_t)(dim + 1);
    const pbw_index *v = mesh->simplices + at, *next = mesh->neighbors + at;
    double side[4], least, bound;
    unsigned k, leave;
    PBW__PREFETCH(next);                             /* so that it comes with the corners */
    bound = dim == 3 ? pbwq__sides3(mesh->points, v, p, side) : pbwq__sides2(mesh->points, v, p, side);
    k = side[1] < side[0];
    leave = side[2] < side[k] ? 2 : k;
    leave = dim == 3 && side[3] < side[leave] ? 3 : leave;
    least = side[leave];
    location->on = 0;
    if (PBW__UNLIKELY(!(least < -bound))) {
        leave = least > bound ? PBWQ__INSIDE : pbwq__side_exact(mesh, v, p, grid, &location->on);
    }
    if (leave >= PBWQ__INSIDE || next[leave] == PBW_NONE || location->steps++ == mesh->simplex_count) {
        location->leave = leave >= PBWQ__INSIDE || next[leave] == PBW_NONE ? leave : PBWQ__MOVED;
        return 0;
    }
    location->simplex = next[leave];
    return 1;
}

/* Walks to p from location->simplex. */
static void pbwq__walk_to(const pbw_mesh *mesh, pbwq__location *location, const double *p, const pbw__grid *grid)
{
    location->steps = 0;
    while (PBW__BY_DIM(mesh->dim, pbwq__step, mesh, location, p, grid)) {
    }
}

/* Returns the lowest of the tetrahedra round the edge of t that lies in the facets opposite to corners i and j.  Sets
   *hull if the edge lies on the hull; the turn one way then ends there, so we turn the other way too.  Each step
   crosses the facet of the edge and the vertex `stays`; the next one crosses that of the edge and the corner behind.
   */
static pbw_index pbwq__lowest_round_edge(const pbw_mesh *mesh, size_t t, unsigned i, unsigned j, int *hull)
{
    const pbw_index *v = mesh->simplices + t * 4;
    const pbw_index edge = v[0] ^ v[1] ^ v[2] ^ v[3] ^ v[i] ^ v[j];      /* both ends, by exclusive or */
    size_t lowest = t, s = PBW_NONE;
    unsigned way;
    for (way = 0; way < 2 && s != t; way++) {
        unsigned leave = way == 0 ? i : j;
        pbw_index stays = v[i + j - leave];
        for (s = mesh->neighbors[t * 4 + leave]; s != PBW_NONE && s != t; s = mesh->neighbors[s * 4 + leave]) {
            const pbw_index *u = mesh->simplices + s * 4;
            for (leave = 0; u[leave] != stays; leave++) {
            }
            stays ^= u[0] ^ u[1] ^ u[2] ^ u[3] ^ edge;
            lowest = s < lowest ? s : lowest;
        }
        *hull |= s == PBW_NONE;
    }
    return (pbw_index)lowest;
}

/* Given a point of simplex t in the facets opposite to the corners in the set `on`, returns the lowest simplex that
   contains it; *hull tells whether the point is known to lie on the hull. */
static pbw_index pbwq__lowest_with(const pbw_mesh *mesh, size_t t, unsigned on, int *hull)
{
    const size_t corners = (size_t)mesh->dim + 1;
    const unsigned off = ~on & ((1u << corners) - 1);
    unsigned i = 0, j;
    *hull = 0;
    if (on == 0) {
        return (pbw_index)t;
    }
    if ((off & (off - 1)) == 0) {                    /* at a corner */
        for (; (off >> i & 1) == 0; i++) {
        }
        return mesh->incident[mesh->simplices[t * corners + i]];
    }
    for (; (on >> i & 1) == 0; i++) {
    }
    if ((on & (on - 1)) != 0) {                      /* on an edge of a tetrahedron */
        for (j = i + 1; (on >> j & 1) == 0; j++) {
        }
        return pbwq__lowest_round_edge(mesh, t, i, j, hull);
    }
    *hull = mesh->neighbors[t * corners + i] == PBW_NONE;
    return mesh->neighbors[t * corners + i] < t ? mesh->neighbors[t * corners + i] : (pbw_index)t;
}

/* Returns the number of the hull facet where a walk left the mesh; PBW_NONE if there is none or it does not fit. */
PBW__INLINE pbw_index pbwq__facet_left(const pbw_mesh *mesh, const pbwq__location *location)
{
    const uint64_t number = (uint64_t)location->simplex * ((uint64_t)mesh->dim + 1) + location->leave;
    return number < PBW_NONE && location->leave < PBWQ__INSIDE ? (pbw_index)number : PBW_NONE;
}

PBWDEF pbw_index pbw_locate_one(const pbw_mesh *mesh, const double *point, pbw_index hint, pbw_index *hull_facet)
{
    pbwq__location location;
    int k, hull;
    if (hull_facet != NULL) {
        *hull_facet = PBW_NONE;
    }
    if (mesh == NULL || point == NULL || mesh->simplex_count == 0 || mesh->neighbors == NULL) {
        return PBW_NONE;
    }
    for (k = 0; k < mesh->dim; k++) {
        if (!(pbw__abs(point[k]) <= DBL_MAX)) {
            return PBW_NONE;
        }
    }
    location.simplex = hint < mesh->simplex_count ? hint : 0;
    pbwq__walk_to(mesh, &location, point, NULL);
    if (location.leave == PBWQ__INSIDE) {
        return pbwq__lowest_with(mesh, location.simplex, location.on, &hull);
    }
    if (hull_facet != NULL) {
        *hull_facet = pbwq__facet_left(mesh, &location);
    }
    return PBW_NONE;
}
/* ------------------------------------------------------------------------------------------------------
   >>batch        Many queries at a time: sorted, cut into blocks, answered by all threads; location; lists.
   In: a mesh, query points.  Out: for each query an item in an array, or a list.
   Holds: sizes of blocks depend on the number of queries only, so no answer depends on the number of threads.

   A batch is sorted along a Hilbert curve, as points are in >>order.  A walk starts where the last one of its lane
   ended, see below; the first one starts from the nearest of a few vertices.  Lists take two passes: each block
   writes its lists into a chunk; once all lengths are known, the chunks are copied to one array.
   ------------------------------------------------------------------------------------------------------ */
#define PBWQ__BLOCK_QUERIES 512

/* A vertex and its computed distance, see >>distance; done: pbwq__near_few has looked at its neighbours; in >>boxes
   the number of the vertex along the curve. */
typedef struct pbwq__candidate { double squared, slack; pbw_index vertex, done; } pbwq__candidate;
typedef struct pbwq__entry { uint64_t key; uint32_t value, stamp; } pbwq__entry;

/* A hash table from keys to numbers.  Entries with another stamp are empty. */
typedef struct pbwq__set {
    pbwq__entry *entry;
    size_t capacity, count;                          /* capacity: a power of two */
    uint32_t stamp;
} pbwq__set;

typedef struct pbwq__cavity pbwq__cavity;                  /* see >>interpolate */
typedef struct pbwq__tree pbwq__tree;                      /* see >>boxes */

/* The scratch memory of one task; its arrays grow. */
typedef struct pbwq__scratch {
    pbw_memory *memory;
    int failed;                                      /* out of memory */
    int moved;                                      /* points of the mesh have moved */
    pbwq__set seen, other;
    pbw_index *list;
    size_t list_capacity;
    pbwq__candidate *found;
    size_t found_capacity, found_count;
    pbwq__cavity *cavity;
} pbwq__scratch;

/* The lists of a block, each as its number, its length and its items; value[i] belongs to the item in word[i]. */
typedef struct pbwq__chunk {
    pbw_index *word;
    double *value;
    size_t words, word_capacity, value_capacity;
} pbwq__chunk;

typedef struct pbwq__queries pbwq__queries;
typedef void pbwq__answer(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t from, size_t to);

struct pbwq__queries {
    pbw__context context;
    pbw__grid grid;                                  /* none, but it says that rounding is to nearest */
    const pbw_mesh *mesh;
    const pbw_lists *stars;                          /* the caller's, or own_stars */
    pbw_lists own_stars;
    const pbwq__tree *tree;
    pbw__input input;                                /* the query points */
    pbw__vertices sorted;                            /* their order along the curve */
    pbwq__answer *answer;
    size_t grain;                                    /* items in a block */
    pbwq__chunk *chunk;                               /* per block, if the answers are lists */
    int with_values;                                 /* the lists have values */
    size_t *first;
    pbw_index *item;
    double *value;
    pbw_index *simplices, *facets, *vertices;        /* of locate, of nearest */
    double *distances, radius;
    double large;                                    /* nearest: see pbwq__find_unit */
    size_t k;
    pbw_scheme scheme;
};

/* Makes room for `needed` items.  If memory is short, sets scratch->failed and returns 0. */
static int pbwq__room(pbwq__scratch *scratch, void *array, size_t *capacity, size_t needed, size_t size)
{
    scratch->failed |= needed > *capacity && !pbw_memory_grow(scratch->memory, array, capacity, needed, 0, size);
    return needed <= *capacity;
}

PBW__INLINE size_t pbwq__set_slot(const pbwq__set *set, uint64_t key)
{
    size_t at = pbw__hash_entry(key, set->capacity);
    while (set->entry[at].stamp == set->stamp && set->entry[at].key != key) {
        at = (at + 1) & (set->capacity - 1);
    }
    return at;
}

static PBW__NOINLINE int pbwq__set_grow(pbwq__scratch *scratch, pbwq__set *set)
{
    pbwq__set bigger;
    size_t i;
    bigger.capacity = set->capacity == 0 ? 256 : 4 * set->capacity;
    bigger.count = set->count;
    bigger.stamp = 1;
    bigger.entry = (pbwq__entry *)pbw__allocate(scratch->memory, bigger.capacity, sizeof(pbwq__entry));
    if (bigger.entry == NULL) {
        scratch->failed = 1;
        return 0;
    }
    memset(bigger.entry, 0, bigger.capacity * sizeof(pbwq__entry));
    for (i = 0; i < set->capacity; i++) {
        if (set->entry[i].stamp == set->stamp) {
            size_t at = pbwq__set_slot(&bigger, set->entry[i].key);
            bigger.entry[at] = set->entry[i];
            bigger.entry[at].stamp = 1;
        }
    }
    pbw__release(scratch->memory, set->entry, set->capacity, sizeof(pbwq__entry));
    *set = bigger;
    return 1;
}

/* Clears a set.  Invariant, here and in pbwq__set_add: one more number fits without growth.  Returns 0 if memory is
   short. */
static int pbwq__set_clear(pbwq__scratch *scratch, pbwq__set *set)
{
    set->count = 0;
    if (set->capacity == 0 || set->stamp == 0xffffffffu) {
        pbw__release(scratch->memory, set->entry, set->capacity, sizeof(pbwq__entry));
        memset(set, 0, sizeof(*set));
        return pbwq__set_grow(scratch, set);
    }
    set->stamp++;
    return 1;
}

/* Returns where the number of a key is.  *added: the key is new, and its number is `value`.  NULL if memory is
   short. */
PBW__INLINE uint32_t *pbwq__set_add(pbwq__scratch *scratch, pbwq__set *set, uint64_t key, uint32_t value, int *added)
{
    size_t at = pbwq__set_slot(set, key);
    pbwq__entry *entry = set->entry + at;
    *added = entry->stamp != set->stamp;
    if (*added) {
        if (PBW__UNLIKELY(2 * set->count >= set->capacity)) {
            if (!pbwq__set_grow(scratch, set)) {
                return NULL;
            }
            entry = set->entry + pbwq__set_slot(set, key);
        }
        set->count++;
        entry->key = key;
        entry->value = value;
        entry->stamp = set->stamp;
    }
    return &entry->value;
}

static void pbwq__cavity_free(pbw_memory *memory, pbwq__cavity *cavity);

static pbw_status pbwq__answer_range(void *arg, size_t from, size_t to)
{
    pbwq__queries *queries = (pbwq__queries *)arg;
    pbw_memory *memory = &queries->context.memory;
    pbwq__scratch scratch;
    memset(&scratch, 0, sizeof(scratch));
    scratch.memory = memory;
    queries->answer(queries, &scratch, from / queries->grain, from, to);
    pbw__release(memory, scratch.seen.entry, scratch.seen.capacity, sizeof(pbwq__entry));
    pbw__release(memory, scratch.other.entry, scratch.other.capacity, sizeof(pbwq__entry));
    pbw__release(memory, scratch.list, scratch.list_capacity, sizeof(pbw_index));
    pbw__release(memory, scratch.found, scratch.found_capacity, sizeof(pbwq__candidate));
    pbwq__cavity_free(memory, scratch.cavity);
    return scratch.failed ? PBW_ERROR_MEMORY : scratch.moved ? PBW_ERROR_ARGUMENT : PBW_OK;
}

/* Calls `answer` for `items` queries, or other items, in blocks of `grain`. */
static pbw_status pbwq__answer_all(pbwq__queries *queries, pbwq__answer *answer, size_t items, size_t grain)
{
    queries->answer = answer;
    queries->grain = grain;
    return items == 0 ? PBW_OK : pbw__for_range(&queries->context, items, grain, 1.0, pbwq__answer_range, queries);
}

/* ---- order
   Sorting the points counts as a twentieth of a stage's progress. */
typedef struct pbwq__sort_progress { pbw_options options; double begin; } pbwq__sort_progress;

static int pbwq__report_sort(void *user, pbw_stage stage, double done)
{
    const pbwq__sort_progress *outer = (const pbwq__sort_progress *)user;
    return outer->options.progress(outer->options.progress_user, stage, outer->begin + 0.05 * done);
}

/* Sorts one point or more along a curve: sorted->id[1], sorted->id[2], ... are their numbers.  The caller frees
   `sorted` with pbw__vertices_free after success. */
static pbw_status pbwq__sort_points(pbw__context *context, pbw__input *input, pbw__vertices *sorted)
{
    pbwq__sort_progress outer = { context->options, context->reached };
    pbw_status status;
    if (outer.options.progress != NULL) {
        context->options.progress = pbwq__report_sort;
        context->options.progress_user = &outer;
        context->last_done = 0.0;
    }
    input->bare = 1;                                 /* keeps duplicates */
    status = pbw__order(context, input, sorted);
    context->options.progress = outer.options.progress;
    context->options.progress_user = outer.options.progress_user;
    context->last_done = context->reached = outer.begin + 0.05;
    return status;
}

typedef struct pbwq__owned_lists { pbw_memory memory; size_t first, items, values; } pbwq__owned_lists;

/* Frees the arrays of lists.  `memory` counts their bytes. */
static void pbwq__lists_release(pbw_memory *memory, const pbw_lists *lists)
{
    pbwq__owned_lists *owned = (pbwq__owned_lists *)lists->memory;
    if (owned != NULL) {
        pbw__release(memory, (void *)(uintptr_t)lists->first, owned->first, sizeof(size_t));
        pbw__release(memory, (void *)(uintptr_t)lists->item, owned->items, sizeof(pbw_index));
        pbw__release(memory, (void *)(uintptr_t)lists->value, owned->values, sizeof(double));
        pbw__release(memory, owned, 1, sizeof(pbwq__owned_lists));
    }
}

/* Begins a call, checks the arguments that all queries have in common, enters the stage and sorts the query points.
   pbwq__queries_end must follow on any status. */
static pbw_status pbwq__queries_start(pbwq__queries *queries, const pbw_mesh *mesh, const double *points,
                                      size_t count, const pbw_options *options)
{
    const size_t work = points != NULL || mesh == NULL ? count : mesh->simplex_count;
    pbw_status status;
    memset(queries, 0, sizeof(*queries));
    queries->mesh = mesh;
    /* 8192: begin_call starts a thread for so many points; a block of queries is worth one. */
    status = pbw__begin_call(&queries->context, options, work * (8192 / PBWQ__BLOCK_QUERIES));
    if (!pbw__has_arrays(mesh, 1) || (points == NULL && count != 0)) {
        return PBW_ERROR_ARGUMENT;
    }
    queries->input = pbw__input_of(mesh->dim, 0, points, NULL, count);
    queries->input.stride = (size_t)mesh->dim * sizeof(double);
    if (queries->context.options.stride != 0) {
        if (queries->context.options.stride < queries->input.stride) {
            return PBW_ERROR_ARGUMENT;
        }
        queries->input.stride = queries->context.options.stride;
    }
    if (count >= PBW_NONE || count > (size_t)-1 / queries->input.stride) {
        return PBW_ERROR_TOO_LARGE;
    }
    status = status == PBW_OK && pbw__enter_stage(&queries->context, PBW_STAGE_WORK) ? PBW_CANCELLED : status;
    return status == PBW_OK && count > 0 ? pbwq__sort_points(&queries->context, &queries->input, &queries->sorted)
         : status;
}

static pbw_status pbwq__queries_end(pbwq__queries *queries, pbw_status status)
{
    pbw__vertices_free(&queries->context, &queries->sorted);
    pbwq__lists_release(&queries->context.memory, &queries->own_stars);
    return pbw__end_call(&queries->context, status);
}

/* Returns the number of the i-th query along the curve. */
PBW__INLINE size_t pbwq__query_of(const pbwq__queries *queries, size_t i)
{
    return queries->sorted.id[i + 1];
}

/* Returns the vertex nearest to p, by rounded distances, of a few spread over the mesh. */
static pbw_index pbwq__start_vertex(const pbw_mesh *mesh, const double *p)
{
    const size_t some = 48, dim = (size_t)mesh->dim;
    double least = HUGE_VAL;
    pbw_index best = mesh->simplices[0];
    size_t i, v;
    for (i = 0; i < some; i++) {
        v = (size_t)((double)mesh->simplex_count * ((double)i / (double)some));
        v = mesh->simplices[v * (dim + 1)];
        if (pbw__squared(mesh->points + v * dim, p, mesh->dim) < least) {
            least = pbw__squared(mesh->points + v * dim, p, mesh->dim);
            best = (pbw_index)v;
        }
    }
    return best;
}

/* ---- walks in turn
   Each step of a walk waits for memory: where it is, only the step before tells.  Where the mesh does not fit the
   caches, a block makes several walks in turn, each for its own part of the queries, and each prefetches what its
   next turn reads (Chen et al. 2004, "Improving hash join performance through prefetching"; Kocberber et al. 2015,
   "Asynchronous memory access chaining"). */
#define PBWQ__LANES 8

typedef struct pbwq__lane {
    size_t next, to;                                 /* its queries along the curve */
    double q[4];                                     /* the next one */
    int fetched;                                     /* how many of the loads that follow one another in its next step
                                                        are prefetched; -1: q has not been read */
    size_t simplex, steps;                           /* of location: where it is, and how many steps it has made */
    pbwq__candidate best;                            /* of a search: the nearest vertex so far */
} pbwq__lane;

/* Makes a step of a walk, or prefetches for one.  several: there are other lanes. */
typedef void pbwq__turn(pbwq__queries *queries, pbwq__scratch *scratch, pbwq__lane *lane, int several, int dim);

/* Returns how many of `count` queries are a block of walks: in a long block fewer of them come from afar, but there
   should be some 64 blocks for the threads. */
static size_t pbwq__walk_block(size_t count)
{
    return count < 64 * PBWQ__BLOCK_QUERIES ? PBWQ__BLOCK_QUERIES : count < 64 * 2048 ? count / 64 : 2048;
}

/* Returns how many queries for k neighbours each are a block: few if k is large, as the caller is asked whether to go
   on after each block. */
static size_t pbwq__near_block(size_t k)
{
    const size_t neighbors = 64 * PBWQ__BLOCK_QUERIES;
    return k <= 64 ? PBWQ__BLOCK_QUERIES : k < neighbors ? neighbors / k : 1;
}

/* Reads the next query of a lane, unless it has been read.  Returns whether it has read it. */
PBW__INLINE int pbwq__lane_reads(const pbwq__queries *queries, pbwq__lane *lane)
{
    if (lane->fetched >= 0) {
        return 0;
    }
    pbw__fetch(&queries->input, pbwq__query_of(queries, lane->next), lane->q);
    if (lane->next + 1 < lane->to) {
        pbw__fetch_soon(&queries->input, pbwq__query_of(queries, lane->next + 1));
    }
    lane->fetched = 2;                               /* the walk starts where the last one ended */
    return 1;
}

/* Goes on to the next query of a lane. */
PBW__INLINE void pbwq__lane_ends(pbwq__lane *lane)
{
    lane->next++;
    lane->fetched = -1;
}

/* Deals a block of queries to lanes, and starts each lane's walk at a vertex that is near its first query. */
static void pbwq__lanes_start(const pbwq__queries *queries, pbwq__lane *lane, size_t lanes, size_t from, size_t to)
{
    size_t i;
    for (i = 0; i < lanes; i++) {
        lane[i].next = from + (to - from) * i / lanes;
        lane[i].to = from + (to - from) * (i + 1) / lanes;
        lane[i].fetched = -1;
        if (lane[i].next < lane[i].to) {
            pbw__fetch(&queries->input, pbwq__query_of(queries, lane[i].next), lane[i].q);
            lane[i].best.vertex = pbwq__start_vertex(queries->mesh, lane[i].q);
            lane[i].simplex = queries->mesh->incident[lane[i].best.vertex];
        }
    }
}

/* Answers the queries of lanes, by their walks in turn. */
PBW__INLINE void pbwq__take_turns(pbwq__queries *queries, pbwq__scratch *scratch, pbwq__lane *lane, size_t lanes,
                                  pbwq__turn *turn, int dim)
{
    size_t i;
    int busy = 1;
    while (busy && !scratch->failed && !scratch->moved) {
        busy = 0;
        for (i = 0; i < lanes; i++) {
            if (lane[i].next < lane[i].to) {
                turn(queries, scratch, lane + i, lanes > 1, dim);
                busy = 1;
            }
        }
    }
}

/* ---- lists */
PBWDEF void pbw_lists_free(pbw_lists *lists)
{
    if (lists != NULL && lists->memory != NULL) {
        pbw_memory memory = ((pbwq__owned_lists *)lists->memory)->memory;
        pbwq__lists_release(&memory, lists);
    }
    if (lists != NULL) {
        memset(lists, 0, sizeof(*lists));
    }
}

/* Sorts items, and their values with them, by Shell's sort. */
static void pbwq__sort_items(pbw_index *items, double *values, size_t count)
{
    size_t gap, i, j;
    for (gap = count > 64 ? count / 3 : 1; gap > 0; gap = gap == 2 ? 1 : gap / 3) {
        for (i = gap; i < count; i++) {
            const pbw_index item = items[i];
            const double value = values[i];
            for (j = i; j >= gap && items[j - gap] > item; j -= gap) {
                items[j] = items[j - gap];
                values[j] = values[j - gap];
            }
            items[j] = item;
            values[j] = value;
        }
    }
}

/* Adds list `id` of `length` items to a chunk.  Returns where to write its items, NULL if memory is short; sets
   *values to where to write its values, if values is not NULL. */
static pbw_index *pbwq__chunk_add(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t id,
                                  size_t length, double **values)
{
    pbwq__chunk *chunk = queries->chunk + block;
    const size_t at = chunk->words + 2, end = at + length;
    if (!pbwq__room(scratch, &chunk->word, &chunk->word_capacity, end, sizeof(pbw_index))
        || (values != NULL && !pbwq__room(scratch, &chunk->value, &chunk->value_capacity, end, sizeof(double)))) {
        return NULL;
    }
    queries->first[id + 1] = length;
    chunk->word[at - 2] = (pbw_index)id;
    chunk->word[at - 1] = (pbw_index)length;
    chunk->words = end;
    if (values != NULL) {
        *values = chunk->value + at;
    }
    return chunk->word + at;
}

static void pbwq__copy_chunk(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t from, size_t to)
{
    const pbwq__chunk *chunk = queries->chunk + block;
    size_t at, length;
    (void)scratch;
    (void)from;
    (void)to;
    for (at = 2; at <= chunk->words; at += length + 2) {
        const size_t first = queries->first[chunk->word[at - 2]];
        length = chunk->word[at - 1];
        memcpy(queries->item + first, chunk->word + at, length * sizeof(pbw_index));
        if (queries->value != NULL) {
            memcpy(queries->value + first, chunk->value + at, length * sizeof(double));
        }
    }
}

/* Makes `count` lists.  `answer` adds the lists of a block of items, in any order, to the block's chunk. */
static pbw_status pbwq__make_lists(pbwq__queries *queries, pbwq__answer *answer, size_t items, size_t size,
                                   size_t count, pbw_lists *lists)
{
    const int with_values = queries->with_values;
    pbw_memory *memory = &queries->context.memory;
    const size_t blocks = (items + size - 1) / size;
    pbwq__owned_lists *owned = (pbwq__owned_lists *)pbw__allocate(memory, 1, sizeof(pbwq__owned_lists));
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, total = 0;
    if (owned == NULL) {
        return PBW_ERROR_MEMORY;
    }
    memset(owned, 0, sizeof(*owned));
    lists->memory = owned;
    lists->count = count;
    owned->first = count + 1;
    lists->first = queries->first = (size_t *)pbw__allocate_large(&queries->context, count + 1, sizeof(size_t));
    queries->chunk = (pbwq__chunk *)pbw__allocate(memory, blocks, sizeof(pbwq__chunk));
    if (queries->chunk != NULL) {
        memset(queries->chunk, 0, blocks * sizeof(pbwq__chunk));
    }
    if (queries->first != NULL && queries->chunk != NULL) {
        memset(queries->first, 0, (count + 1) * sizeof(size_t));
        status = pbwq__answer_all(queries, answer, items, size);
    }
    if (status == PBW_OK) {
        for (i = 1; i <= count; i++) {
            total = queries->first[i] += total;
        }
        owned->items = total;
        owned->values = with_values ? total : 0;
        lists->item = queries->item = (pbw_index *)pbw__allocate_large(&queries->context, total, sizeof(pbw_index));
        lists->value = queries->value = with_values
                     ? (double *)pbw__allocate_large(&queries->context, total, sizeof(double)) : NULL;
        status = lists->item == NULL || (with_values && lists->value == NULL) ? PBW_ERROR_MEMORY
               : pbwq__answer_all(queries, pbwq__copy_chunk, items, size);
    }
    for (i = 0; i < blocks && queries->chunk != NULL; i++) {
        pbw__release(memory, queries->chunk[i].word, queries->chunk[i].word_capacity, sizeof(pbw_index));
        pbw__release(memory, queries->chunk[i].value, queries->chunk[i].value_capacity, sizeof(double));
    }
    pbw__release(memory, queries->chunk, blocks, sizeof(pbwq__chunk));
    return status;
}

/* Ends the queries; from then on the lists count their bytes in a memory of their own. */
static pbw_status pbwq__lists_end(pbwq__queries *queries, pbw_status status, pbw_lists *lists)
{
    status = pbwq__queries_end(queries, status);
    if (lists->memory != NULL) {
        ((pbwq__owned_lists *)lists->memory)->memory = queries->context.memory;
    }
    if (status != PBW_OK) {
        pbw_lists_free(lists);
    }
    return status;
}

/* ---- locate */
PBW__INLINE void pbwq__locate_turn(pbwq__queries *queries, pbwq__scratch *scratch, pbwq__lane *lane, int several,
                                   int dim)
{
    const pbw_mesh *mesh = queries->mesh;
    const size_t query = pbwq__query_of(queries, lane->next);
    pbwq__location location;
    int hull, inside, k;
    if (pbwq__lane_reads(queries, lane)) {
        lane->steps = 0;
    }
    if (several && lane->fetched == 0 && mesh->original == NULL) {       /* else the points are in the caches */
        const pbw_index *v = mesh->simplices + lane->simplex * (size_t)(dim + 1);
        for (k = 0; k <= dim; k++) {
            PBW__PREFETCH(mesh->points + v[k] * (size_t)dim);
        }
        lane->fetched = 1;
        return;
    }
    location.simplex = lane->simplex;
    location.steps = lane->steps;
    while (pbwq__step(mesh, &location, lane->q, &queries->grid, dim)) {
        if (several) {
            PBW__PREFETCH(mesh->simplices + location.simplex * (size_t)(dim + 1));
            PBW__PREFETCH(mesh->neighbors + location.simplex * (size_t)(dim + 1));
            lane->simplex = location.simplex;
            lane->steps = location.steps;
            lane->fetched = 0;
            return;
        }
    }
    lane->simplex = location.simplex;
    scratch->moved |= location.leave == PBWQ__MOVED;
    inside = location.leave == PBWQ__INSIDE;
    queries->simplices[query] = inside ? pbwq__lowest_with(mesh, location.simplex, location.on, &hull) : PBW_NONE;
    if (queries->facets != NULL) {
        queries->facets[query] = inside ? PBW_NONE : pbwq__facet_left(mesh, &location);
    }
    pbwq__lane_ends(lane);
}

/* In small meshes one walk after the other takes less time. */
static void pbwq__locate_block(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t from, size_t to)
{
    const pbw_mesh *mesh = queries->mesh;
    const int few = mesh->simplex_count < 65536 || (mesh->original != NULL && mesh->point_count < 65536);
    pbwq__lane lane[PBWQ__LANES];
    (void)block;
    pbwq__lanes_start(queries, lane, few ? 1 : PBWQ__LANES, from, to);
    if (few) {
        PBW__BY_DIM(mesh->dim, pbwq__take_turns, queries, scratch, lane, 1, pbwq__locate_turn);
    } else {
        PBW__BY_DIM(mesh->dim, pbwq__take_turns, queries, scratch, lane, PBWQ__LANES, pbwq__locate_turn);
    }
}

PBWDEF pbw_status pbw_locate(const pbw_mesh *mesh, const double *points, size_t count, const pbw_options *options,
                             pbw_index *simplices, pbw_index *hull_facets)
{
    pbwq__queries queries;
    pbw_status status;
    if (simplices == NULL && count != 0) {
        return PBW_ERROR_ARGUMENT;
    }
    status = pbwq__queries_start(&queries, mesh, points, count, options);
    if (status == PBW_OK && mesh->simplex_count == 0 && count > 0) {
        memset(simplices, 0xff, count * sizeof(pbw_index));          /* PBW_NONE */
        if (hull_facets != NULL) {
            memset(hull_facets, 0xff, count * sizeof(pbw_index));
        }
    } else if (status == PBW_OK) {
        queries.simplices = simplices;
        queries.facets = hull_facets;
        status = pbwq__answer_all(&queries, pbwq__locate_block, count, pbwq__walk_block(count));
    }
    return pbwq__queries_end(&queries, status);
}
/* ------------------------------------------------------------------------------------------------------
   >>finder       Where walks of single queries start: nested grids.
   In: a mesh; then query points, one at a time.  Out: for each bin of a grid over the vertices, a simplex at the
   vertex nearest to the bin's centre; for a bin with many vertices, a finer grid over them, and so on.
   Holds: a finished finder is never written, so any number of threads may use it at once.
   ------------------------------------------------------------------------------------------------------ */
#define PBWQ__MANY    64                              /* vertices: a bin with more gets a finer grid */
#define PBWQ__DEEPEST 12                              /* levels of nested grids */

typedef struct pbwq__bin { pbw_index start, finer; } pbwq__bin;        /* a simplex; the finer grid's number, or 0 */

/* A grid: bins first .. first+count-1, side[k] along axis k; vertices from .. to-1 of pbwq__binning. */
typedef struct pbwq__bins {
    double low[3], scale[3];
    size_t side[3], first, count;
    size_t from, to;
    int depth;
} pbwq__bins;

struct pbw_finder {
    const pbw_mesh *mesh;
    pbw_memory memory;
    pbwq__bins *grids;
    pbwq__bin *bins;                                  /* of all grids */
    size_t grids_capacity, bins_capacity, grid_count, bin_count;
};

/* A slice of the points: how many are vertices, then where the first one is listed; their box. */
typedef struct pbwq__slice { size_t first; pbw__box box; } pbwq__slice;
#define PBWQ__SLICE 16384
#define PBWQ__COUNTED 8192                           /* vertices of a range */

typedef struct pbwq__binning {
    pbwq__queries *queries;
    pbw_finder *finder;
    pbwq__slice *slice;
    const pbwq__bins *grid;                          /* in work */
    pbw_index *vertices, *sorted;                    /* those of a grid are contiguous */
    uint64_t *nearest;                               /* per bin of a grid: the squared distance of a vertex from the
                                                        centre, in edges of a bin, as a float; then its number in
                                                        `vertices`: the least */
    size_t *counts;                                  /* per bin of a grid: vertices; then where the next goes */
} pbwq__binning;

/* Returns the bin of p, or the nearest one.  Adds to *centre the squared distance from its centre, in edges. */
PBW__INLINE size_t pbwq__bin_of(const pbwq__bins *grid, int dim, const double *p, double *centre)
{
    size_t bin = 0;
    int k;
    for (k = dim; k-- > 0; ) {
        double at = (p[k] - grid->low[k]) * grid->scale[k];
        const double last = (double)(grid->side[k] - 1);
        at = at > 0.0 ? at < last ? at : last : 0.0;         /* 0 for the NaN of an overflow too */
        bin = bin * grid->side[k] + (size_t)at;
        *centre += (at - (double)(size_t)at - 0.5) * (at - (double)(size_t)at - 0.5);
    }
    return grid->first + bin;
}

static pbw_status pbwq__slice_count(void *arg, size_t from, size_t to)
{
    const pbwq__binning *binning = (const pbwq__binning *)arg;
    size_t *count = &binning->slice[from / PBWQ__SLICE].first;
    for (*count = 0; from < to; from++) {
        *count += binning->finder->mesh->incident[from] != PBW_NONE;
    }
    return PBW_OK;
}

static pbw_status pbwq__slice_list(void *arg, size_t from, size_t to)
{
    const pbwq__binning *binning = (const pbwq__binning *)arg;
    const pbw_mesh *mesh = binning->finder->mesh;
    pbwq__slice *slice = binning->slice + from / PBWQ__SLICE;
    pbw_index *vertex = binning->vertices + slice->first;
    pbw__box_reset(&slice->box, 0);
    for (; from < to; from++) {
        if (mesh->incident[from] != PBW_NONE) {
            *vertex++ = (pbw_index)from;
            pbw__box_add(&slice->box, mesh->points + from * (size_t)mesh->dim, mesh->dim);
        }
    }
    return PBW_OK;
}

/* Lists the vertices.  Returns their box. */
static pbw__box pbwq__bins_list(pbwq__binning *binning, pbwq__bins *grid)
{
    pbw__context *context = &binning->queries->context;
    const pbw_mesh *mesh = binning->finder->mesh;
    const size_t slices = (mesh->point_count + PBWQ__SLICE - 1) / PBWQ__SLICE;
    pbw__box box;
    size_t i;
    pbw__box_reset(&box, 0);
    if (pbw__for_range(context, mesh->point_count, PBWQ__SLICE, 0.1, pbwq__slice_count, binning) == PBW_OK) {
        for (i = 0; i < slices; i++) {
            const size_t here = binning->slice[i].first;
            binning->slice[i].first = grid->to;
            grid->to += here;
        }
        (void)pbw__for_range(context, mesh->point_count, PBWQ__SLICE, 0.3, pbwq__slice_list, binning);
    }
    for (i = 0; i < slices && !PBW__LOAD(&context->cancelled); i++) {
        const size_t end = i + 1 < slices ? binning->slice[i + 1].first : grid->to;
        if (binning->slice[i].first < end) {
            pbw__box_add(&box, binning->slice[i].box.low, mesh->dim);
            pbw__box_add(&box, binning->slice[i].box.high, mesh->dim);
        }
    }
    return box;
}

/* The box of a grid's vertices. */
static pbw__box pbwq__bins_box(const pbwq__binning *binning, const pbwq__bins *grid)
{
    const pbw_mesh *mesh = binning->finder->mesh;
    pbw__box box;
    size_t i;
    pbw__box_reset(&box, 0);
    for (i = grid->from; i < grid->to; i++) {
        pbw__box_add(&box, mesh->points + binning->vertices[i] * (size_t)mesh->dim, mesh->dim);
    }
    return box;
}

/* Chooses the edge of a grid of cubes: starts with the longest side of the box, at most 2 bins along each axis, and
   halves it while the bins stay at most a quarter of the vertices plus 1. */
static void pbwq__bins_measure(pbwq__bins *grid, pbw__box box, int dim)
{
    const double most = (double)(grid->to - grid->from) * 0.25 + 1.0;
    double bins, edge = 0.0;
    int k;
    for (k = 0; k < dim; k++) {
        edge = pbw__max(edge, box.high[k] - box.low[k]);
        grid->low[k] = box.low[k];
        grid->scale[k] = 0.0;
        grid->side[k] = 1;
    }
    grid->count = 1;
    if (!(edge > 0.0 && edge <= DBL_MAX)) {
        return;                                      /* too large to measure: one bin */
    }
    for (;;) {
        const double smaller = edge * 0.5;
        for (bins = 1.0, k = 0; k < dim; k++) {
            const double side = (box.high[k] - box.low[k]) / smaller;
            bins *= (double)(size_t)(side < most ? side : most) + 1.0;
        }
        if (bins > most) {
            break;
        }
        edge = smaller;
    }
    if (!(1.0 / edge <= DBL_MAX)) {
        return;                                      /* too small to divide: one bin */
    }
    for (k = 0; k < dim; k++) {
        grid->side[k] = (size_t)((box.high[k] - box.low[k]) / edge) + 1;
        grid->scale[k] = 1.0 / edge;
        grid->count *= grid->side[k];
    }
}

/* Counts a range of a grid's vertices in their bins, and finds those nearest to the centres. */
static pbw_status pbwq__bins_count(void *arg, size_t from, size_t to)
{
    const pbwq__binning *binning = (const pbwq__binning *)arg;
    const pbw_mesh *mesh = binning->finder->mesh;
    const pbwq__bins *grid = binning->grid;
    const int alone = binning->queries->context.threads == 1 || grid->to - grid->from <= PBWQ__COUNTED;
    size_t i, at;
    for (i = grid->from + from; i < grid->from + to; i++) {
        const double *p = mesh->points + binning->vertices[i] * (size_t)mesh->dim;
        double centre = 0.0;
        float distance;
        uint32_t bits;                               /* they ascend with a float from 0 on */
        uint64_t key, old;
        at = pbwq__bin_of(grid, mesh->dim, p, &centre) - grid->first;
        distance = (float)centre;
        memcpy(&bits, &distance, sizeof(bits));
        key = (uint64_t)bits << 32 | i;
        if (alone) {
            binning->counts[at]++;
            binning->nearest[at] = key < binning->nearest[at] ? key : binning->nearest[at];
            continue;
        }
        (void)PBW__ADD(binning->counts + at, 1);
        old = PBW__LOAD(binning->nearest + at);
        while (key < old && !PBW__CAS(binning->nearest + at, &old, key)) {
        }
    }
    return PBW_OK;
}

/* Sets the start of each bin of a grid, and counts its vertices.  An empty bin starts where the bin before does. */
static pbw_status pbwq__bins_fill(pbwq__binning *binning, const pbwq__bins *grid)
{
    const pbw_mesh *mesh = binning->finder->mesh;
    pbwq__bin *bins = binning->finder->bins + grid->first;
    pbw_index last = mesh->incident[binning->vertices[grid->from]];
    pbw_status status;
    size_t at;
    memset(binning->counts, 0, grid->count * sizeof(size_t));
    memset(binning->nearest, 0xff, grid->count * sizeof(uint64_t));
    binning->grid = grid;
    status = pbw__for_range(&binning->queries->context, grid->to - grid->from, PBWQ__COUNTED, 1.0,
                             pbwq__bins_count, binning);
    for (at = 0; at < grid->count && status == PBW_OK; at++) {
        if (binning->counts[at] > 0) {
            last = mesh->incident[binning->vertices[(uint32_t)binning->nearest[at]]];
        }
        bins[at].start = last;
        bins[at].finer = 0;
    }
    return status;
}

/* Makes finer grids for the bins of a grid that have many vertices. */
static pbw_status pbwq__bins_refine(const pbwq__binning *binning, pbwq__bins grid)
{
    pbw_finder *finder = binning->finder;
    pbw_memory *memory = &binning->queries->context.memory;
    const pbw_mesh *mesh = finder->mesh;
    size_t i, at, end = grid.from, full = 0;
    for (at = 0; at < grid.count; at++) {
        full += binning->counts[at] > PBWQ__MANY;
    }
    if (full == 0 || grid.count == 1 || grid.depth == PBWQ__DEEPEST) {
        return PBW_OK;
    }
    if (!pbw_memory_grow(memory, &finder->grids, &finder->grids_capacity, finder->grid_count, full,
                         sizeof(pbwq__bins))) {
        return PBW_ERROR_MEMORY;
    }
    for (at = 0; at < grid.count; at++) {
        pbwq__bins *finer = finder->grids + finder->grid_count;
        const size_t count = binning->counts[at];
        binning->counts[at] = end;
        end += count;
        if (count > PBWQ__MANY) {
            finder->bins[grid.first + at].finer = (pbw_index)finder->grid_count++;
            finer->from = end - count;
            finer->to = end;
            finer->depth = grid.depth + 1;
        }
    }
    for (i = grid.from; i < grid.to; i++) {
        const size_t v = binning->vertices[i];
        double distance = 0.0;
        at = pbwq__bin_of(&grid, mesh->dim, mesh->points + v * (size_t)mesh->dim, &distance) - grid.first;
        binning->sorted[binning->counts[at]++] = (pbw_index)v;
    }
    memcpy(binning->vertices + grid.from, binning->sorted + grid.from, (grid.to - grid.from) * sizeof(pbw_index));
    return PBW_OK;
}

static pbw_status pbwq__bins_make(pbwq__binning *binning)
{
    pbw_finder *finder = binning->finder;
    pbw__context *context = &binning->queries->context;
    pbw_memory *memory = &context->memory;
    pbw__box box;
    pbw_status status;
    size_t g;
    finder->grid_count = 1;
    memset(finder->grids, 0, sizeof(pbwq__bins));
    box = pbwq__bins_list(binning, finder->grids);
    status = PBW__LOAD(&context->cancelled) ? PBW_CANCELLED : PBW_OK;
    for (g = 0; g < finder->grid_count && status == PBW_OK; g++) {
        pbwq__bins *grid = finder->grids + g;
        pbwq__bins_measure(grid, g == 0 ? box : pbwq__bins_box(binning, grid), finder->mesh->dim);
        grid->first = finder->bin_count;
        finder->bin_count += grid->count;
        if (!pbw_memory_grow(memory, &finder->bins, &finder->bins_capacity, finder->bin_count, 0,
                             sizeof(*finder->bins))) {
            return PBW_ERROR_MEMORY;
        }
        status = pbwq__bins_fill(binning, grid);
        status = status == PBW_OK ? pbwq__bins_refine(binning, *grid) : status;
    }
    return status;
}

static pbw_status pbwq__finder_fill(pbwq__queries *queries, pbw_finder *finder)
{
    pbw_memory *memory = &queries->context.memory;
    const size_t count = finder->mesh->point_count, most = count / 4 + 8;    /* bins: see pbwq__bins_measure */
    const size_t slices = count / PBWQ__SLICE + 1;
    pbw_status status = PBW_ERROR_MEMORY;
    pbwq__binning binning;
    binning.queries = queries;
    binning.finder = finder;
    binning.vertices = (pbw_index *)pbw__allocate(memory, count, sizeof(pbw_index));
    binning.sorted = (pbw_index *)pbw__allocate(memory, count, sizeof(pbw_index));
    binning.slice = (pbwq__slice *)pbw__allocate(memory, slices, sizeof(pbwq__slice));
    binning.nearest = (uint64_t *)pbw__allocate(memory, most, sizeof(uint64_t));
    binning.counts = (size_t *)pbw__allocate(memory, most, sizeof(size_t));
    if (binning.vertices != NULL && binning.sorted != NULL && binning.slice != NULL && binning.nearest != NULL
        && binning.counts != NULL && PBW__RESIZE(memory, finder, grids, 1)) {
        status = pbwq__bins_make(&binning);
    }
    pbw__release(memory, binning.vertices, count, sizeof(pbw_index));
    pbw__release(memory, binning.sorted, count, sizeof(pbw_index));
    pbw__release(memory, binning.slice, slices, sizeof(pbwq__slice));
    pbw__release(memory, binning.nearest, most, sizeof(uint64_t));
    pbw__release(memory, binning.counts, most, sizeof(size_t));
    return status;
}

PBWDEF pbw_status pbw_finder_create(const pbw_mesh *mesh, const pbw_options *options, pbw_finder **finder)
{
    pbwq__queries queries;
    pbw_status status;
    pbw_finder *made = NULL;
    if (finder == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    *finder = NULL;
    status = pbwq__queries_start(&queries, mesh, NULL, 0, options);
    if (status == PBW_OK) {
        const size_t most = mesh->point_count / PBW__SMALLER(65536) + 1;       /* a thread has little to do */
        queries.context.threads = (size_t)queries.context.threads < most ? queries.context.threads : (int)most;
        made = (pbw_finder *)pbw__allocate(&queries.context.memory, 1, sizeof(pbw_finder));
        status = made == NULL ? PBW_ERROR_MEMORY : PBW_OK;
    }
    if (status == PBW_OK) {
        memset(made, 0, sizeof(*made));
        made->mesh = mesh;
        status = mesh->simplex_count > 0 ? pbwq__finder_fill(&queries, made) : PBW_OK;
    }
    status = pbwq__queries_end(&queries, status);
    if (made != NULL) {
        made->memory = queries.context.memory;
        if (status == PBW_OK) {
            *finder = made;
        } else {
            pbw_finder_free(made);
        }
    }
    return status;
}

PBWDEF pbw_index pbw_finder_locate(const pbw_finder *finder, const double *point, pbw_index *hull_facet)
{
    const pbwq__bin *bin;
    double distance = 0.0;
    if (finder == NULL || point == NULL || finder->bins == NULL) {
        return pbw_locate_one(NULL, NULL, 0, hull_facet);
    }
    bin = finder->bins + pbwq__bin_of(finder->grids, finder->mesh->dim, point, &distance);
    while (bin->finer != 0) {
        bin = finder->bins + pbwq__bin_of(finder->grids + bin->finer, finder->mesh->dim, point, &distance);
    }
    return pbw_locate_one(finder->mesh, point, bin->start, hull_facet);
}

PBWDEF void pbw_finder_free(pbw_finder *finder)
{
    if (finder != NULL) {
        pbw_memory memory = finder->memory;
        PBW__RELEASE(&memory, finder, grids);
        PBW__RELEASE(&memory, finder, bins);
        pbw__release(&memory, finder, 1, sizeof(pbw_finder));
    }
}
/* ------------------------------------------------------------------------------------------------------
   >>distance     Power distances of vertices from a query, in exact order.
   In: a query, vertices.  Out: which is nearer, and distances.
   Holds: rounded distances decide only where they differ by more than their error bounds; elsewhere integers do.
   ------------------------------------------------------------------------------------------------------ */
/* Returns the power distance of a vertex, |v - q|^2 - w, with an error of at most slack: see >>predicates.  The
   parameter `squared` is |v - q|^2 as computed.  Underflow loses less than 2^-1020 in all.  An overflow makes slack
   infinite or NaN.  q[3] is the relative error of squares, 0 if all are exact. */
PBW__INLINE pbwq__candidate pbwq__candidate_of(const pbw_mesh *mesh, const double *q, double squared,
                                               pbw_index vertex)
{
    pbwq__candidate candidate;
    candidate.squared = squared;
    candidate.slack = q[3] * (squared + 1e-280);
    if (mesh->weights != NULL) {
        candidate.squared -= mesh->weights[vertex];
        candidate.slack += q[3] * pbw__abs(mesh->weights[vertex]);
    }
    candidate.vertex = vertex;
    candidate.done = 0;
    return candidate;
}

PBW__INLINE pbwq__candidate pbwq__candidate_at(const pbw_mesh *mesh, int dim, const double *q, pbw_index vertex)
{
    return pbwq__candidate_of(mesh, q, pbw__squared(mesh->points + vertex * (size_t)dim, q, dim), vertex);
}

/* Without weights: returns a square such that a vertex with a larger computed square is certainly farther than a.  It
   exceeds a.squared by d > 2.8 a.slack: 3 a.slack, less the rounding of the sum, an eighth of a.slack.  The slack of
   both together is below 2 a.slack + q[3] d < d.  Likewise, a vertex with a square less than a.squared by as much is
   certainly nearer. */
PBW__INLINE double pbwq__square_limit(const pbwq__candidate *a)
{
    return a->squared + 3.0 * a->slack;
}

/* Looks for a unit, a power of two: all coordinates are multiples of it, at most 2^23 units large, as on lattices.
   Squared distances to queries with such coordinates are exact.  Sets queries->large to 3 * 2^51 units if there is
   one. */
static void pbwq__find_unit(pbwq__queries *queries)
{
    const double *x = queries->mesh->points;
    const size_t count = queries->mesh->point_count * (size_t)queries->mesh->dim;
    double most = 0.0, unit, large;
    size_t i;
    if (queries->mesh->weights != NULL || queries->input.count < queries->mesh->point_count / 16) {
        return;
    }
    for (i = 0; i < count; i += count / 64 + 1) {
        most = pbw__max(most, pbw__abs(x[i]));
    }
    if (!(most > 1e-100 && most < 1e100)) {
        return;
    }
    unit = pbw__power_of_two(pbw__exponent(most) - 20);
    large = 6755399441055744.0 * unit;
    for (i = 0; i < count; i++) {
        if (!(pbw__abs(x[i]) <= 8388608.0 * unit) || (large + x[i]) - large != x[i]) {
            return;
        }
    }
    queries->large = large;
}

/* Returns whether the squares (a-b)^2 and their sums have no rounding errors in any mode, as on lattices: a and b are
   multiples of a unit, a power of two, and at most 2^51 units; `most`, the largest sum as computed, is at most 2^50
   units squared.  Adding and subtracting 3 * 2^51 units changes a number that is no multiple of the unit. */
static int pbwq__squares_fit(double (*term)[2], int count, double most)
{
    const double unit = pbw__power_of_two((pbw__exponent(most) + 1023) / 2 - 536);       /* most < 2^exponent */
    const double limit = 2251799813685248.0 * unit, large = 3.0 * limit;
    int i, k;
    if (!(most < 1e300)) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        for (k = 0; k < 2; k++) {
            const double x = term[i][k];
            if (!(pbw__abs(x) <= limit) || (large + x) - large != x) {
                return 0;
            }
        }
    }
    return 1;
}

/* Returns the exact sign of the sum of the squares (a-b)^2 and of more - less; the first `plus` squares are added,
   the others subtracted.  Sums of 7 products of 37 digits and one of 55 fit a column: see >>exact. */
static PBW__NOINLINE int pbwq__sign_of_squares(double (*term)[2], int plus, int count, double more, double less)
{
    pbw__digit pool[8 * 120], *top = pool, one_digit = 1;
    pbw__integer difference[8], sum, one = { &one_digit, 0, 1 };
    pbw__product product[8];
    double total[2] = { 0.0, 0.0 }, weight[2];
    int unit, i;
    for (i = 0; i < count; i++) {
        const double x = term[i][0] - term[i][1];
        total[i >= plus] += x * x;
    }
    if (more == less && pbwq__squares_fit(term, count, pbw__max(total[0], total[1]))) {
        return (total[0] > total[1]) - (total[0] < total[1]);
    }
    weight[0] = more;
    weight[1] = less;
    unit = pbw__exact_unit(weight, 2, 1024);
    unit = (unit - (unit & 1)) / 2;                  /* its square divides the weights */
    for (i = 0; i < count; i++) {
        unit = pbw__exact_unit(term[i], 2, unit);
    }
    for (i = 0; i < count; i++) {
        difference[i] = pbw__exact_difference(term[i][0], term[i][1], unit, &top);
        product[i].factor[0] = product[i].factor[1] = difference + i;
        product[i].negative = i >= plus;
    }
    difference[count] = pbw__exact_difference(more, less, 2 * unit, &top);
    product[count].factor[0] = difference + count;
    product[count].factor[1] = &one;
    product[count].negative = 0;
    sum = pbw__exact_sum(product, count + 1, &top);
    return pbw__exact_sign(&sum);
}

static PBW__NOINLINE int pbwq__compare_exactly(const pbw_mesh *mesh, const double *q, const pbwq__candidate *a,
                                               const pbwq__candidate *b)
{
    const size_t dim = (size_t)mesh->dim;
    double term[6][2];
    size_t k;
    for (k = 0; k < dim; k++) {
        term[k][0] = mesh->points[a->vertex * dim + k];
        term[dim + k][0] = mesh->points[b->vertex * dim + k];
        term[k][1] = term[dim + k][1] = q[k];
    }
    return pbwq__sign_of_squares(term, mesh->dim, 2 * mesh->dim,
                                 mesh->weights != NULL ? mesh->weights[b->vertex] : 0.0,
                                 mesh->weights != NULL ? mesh->weights[a->vertex] : 0.0);
}

/* Returns -1 if a is nearer to q than b, 0 if both are equally near. */
PBW__INLINE int pbwq__compare(const pbw_mesh *mesh, const double *q, const pbwq__candidate *a,
                              const pbwq__candidate *b)
{
    const double gap = a->squared - b->squared, slack = a->slack + b->slack;
    return gap > slack ? 1 : gap < -slack ? -1 : slack == 0.0 ? 0 : pbwq__compare_exactly(mesh, q, a, b);
}

/* Returns whether a comes before b, another vertex: it is nearer, or as near and has the lower index. */
PBW__INLINE int pbwq__comes_before(const pbw_mesh *mesh, const double *q, const pbwq__candidate *a,
                                   const pbwq__candidate *b)
{
    const int order = pbwq__compare(mesh, q, a, b);
    return order != 0 ? order < 0 : a->vertex < b->vertex;
}

/* Returns whether a is within the radius. */
PBW__INLINE int pbwq__is_within(const pbw_mesh *mesh, const double *q, const pbwq__candidate *a, double radius)
{
    const double squared = radius * radius, gap = a->squared - squared;
    const double slack = a->slack + PBW__REACH_ERROR * DBL_EPSILON * squared;
    const size_t dim = (size_t)mesh->dim;
    double term[4][2];
    size_t k;
    if (PBW__LIKELY(gap > slack || gap < -slack)) {
        return gap < 0.0;
    }
    for (k = 0; k < dim; k++) {
        term[k][0] = mesh->points[a->vertex * dim + k];
        term[k][1] = q[k];
    }
    term[dim][0] = radius;
    term[dim][1] = 0.0;
    return pbwq__sign_of_squares(term, mesh->dim, mesh->dim + 1, 0.0,
                                 mesh->weights != NULL ? mesh->weights[a->vertex] : 0.0) <= 0;
}

/* Returns the distance of a candidate if its square underflows or overflows. */
static PBW__NOINLINE double pbwq__distance_scaled(const pbw_mesh *mesh, const double *q, const pbwq__candidate *a)
{
    const double *p = mesh->points + a->vertex * (size_t)mesh->dim;
    const double scale = a->squared < 1.0 ? 4.149515568880993e+180 : 2.409919865102884e-181;     /* 2^600, 2^-600 */
    double sum = 0.0;
    int k;
    for (k = 0; k < mesh->dim; k++) {
        const double x = a->squared < 1.0 ? (p[k] - q[k]) * scale : p[k] * scale - q[k] * scale;
        sum += x * x;
    }
    return pbw__square_root(sum) / scale;
}

/* Returns the distance, or with weights the power distance, as the caller gets it. */
PBW__INLINE double pbwq__distance_of(const pbw_mesh *mesh, const double *q, const pbwq__candidate *a)
{
    return mesh->weights != NULL ? a->squared
         : PBW__LIKELY(a->squared > 1e-280 && a->squared < 1e300) ? pbw__square_root(a->squared)
         : pbwq__distance_scaled(mesh, q, a);
}

/* ------------------------------------------------------------------------------------------------------
   >>nearest      Stars; the k nearest vertices; the vertices in a ball.
   In: a mesh, its stars.  Out: vertices in the exact order of >>distance, lists.

   Up to a constant, the power distances from q are the values of a convex function at the vertices, linear on each
   simplex.  At a vertex that is no minimum it decreases within the cone of some simplex, hence along an edge.  So
     - steps to strictly nearer neighbours end at a nearest vertex;
     - equally near minima are connected by edges among them;
     - each other vertex has a strictly nearer neighbour, so the next nearest is a neighbour of one of those before;
     - the vertices within a radius are connected.
   ------------------------------------------------------------------------------------------------------ */
#define PBWQ__NEAR_LIST 64                            /* up to so many are kept in a sorted list, more in a heap */

/* ---- stars */
/* Adds the list of a vertex's neighbours, by a walk round it, breadth first. */
static void pbwq__star_of(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, pbw_index vertex)
{
    const pbw_mesh *mesh = queries->mesh;
    const size_t corners = (size_t)mesh->dim + 1;
    size_t count = 0, met = 1, next, k;
    pbw_index *items;
    int added;
    if (!pbwq__set_clear(scratch, &scratch->seen) || !pbwq__set_clear(scratch, &scratch->other)
        || pbwq__set_add(scratch, &scratch->seen, mesh->incident[vertex], 0, &added) == NULL
        || pbwq__set_add(scratch, &scratch->other, vertex, 0, &added) == NULL
        || !pbwq__room(scratch, &scratch->list, &scratch->list_capacity, 64, sizeof(pbw_index))) {
        return;
    }
    scratch->list[0] = mesh->incident[vertex];          /* simplices at even indices, neighbours at odd ones */
    for (next = 0; next < met; next++) {
        const size_t t = scratch->list[2 * next];
        const pbw_index *v = mesh->simplices + t * corners;
        if (!pbwq__room(scratch, &scratch->list, &scratch->list_capacity, 2 * (met + count) + 16,
                        sizeof(pbw_index))) {
            return;
        }
        for (k = 0; k < corners; k++) {
            const pbw_index s = mesh->neighbors[t * corners + k];
            if (pbwq__set_add(scratch, &scratch->other, v[k], 0, &added) == NULL) {
                return;
            }
            if (added) {
                scratch->list[2 * count++ + 1] = v[k];
            }
            if (v[k] != vertex && s != PBW_NONE) {
                if (pbwq__set_add(scratch, &scratch->seen, s, 0, &added) == NULL) {
                    return;
                }
                if (added) {
                    scratch->list[2 * met++] = s;
                }
            }
        }
    }
    items = pbwq__chunk_add(queries, scratch, block, vertex, count, NULL);
    for (k = 0; k < count && items != NULL; k++) {
        items[k] = scratch->list[2 * k + 1];
    }
}

/* Makes the stars of the vertices with incident simplices in this range: this follows the curve. */
static void pbwq__stars_block(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t from, size_t to)
{
    const pbw_mesh *mesh = queries->mesh;
    const size_t corners = (size_t)mesh->dim + 1;
    size_t i;
    for (i = from * corners; i < to * corners && !scratch->failed; i++) {
        if (mesh->incident[mesh->simplices[i]] == i / corners) {
            pbwq__star_of(queries, scratch, block, mesh->simplices[i]);
        }
    }
}

PBWDEF pbw_status pbw_stars(const pbw_mesh *mesh, const pbw_options *options, pbw_lists *stars)
{
    pbwq__queries queries;
    pbw_status status;
    if (stars == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(stars, 0, sizeof(*stars));
    status = pbwq__queries_start(&queries, mesh, NULL, 0, options);
    if (status == PBW_OK) {
        status = pbwq__make_lists(&queries, pbwq__stars_block, mesh->simplex_count, 4096, mesh->point_count, stars);
    }
    return pbwq__lists_end(&queries, status, stars);
}

/* ---- searches: the result is in scratch->found */
/* Steps from *best to a nearer neighbour, if there is one, and returns -1.  Otherwise *best is a nearest vertex:
   returns whether a neighbour is as near.  Without weights computed squares mostly decide, see pbwq__square_limit;
   otherwise all neighbours are compared exactly. */
PBW__INLINE int pbwq__descend(const pbwq__queries *queries, const double *q, pbwq__candidate *best, int dim)
{
    const pbw_mesh *mesh = queries->mesh;
    const pbw_index *item = queries->stars->item;
    const pbw_index from = best->vertex;
    size_t i = queries->stars->first[from];
    const size_t end = queries->stars->first[from + (size_t)1];
    int equal = 0;
    if (mesh->weights == NULL) {                     /* branchless: unpredictable */
        double least = HUGE_VAL;
        pbw_index at = from;
        size_t j;
        for (j = i; j < end; j++) {
            const double squared = pbw__squared(mesh->points + item[j] * (size_t)dim, q, dim);
            at = squared < least ? item[j] : at;
            least = squared < least ? squared : least;
        }
        if (least > pbwq__square_limit(best) && least < HUGE_VAL) {
            return 0;
        }
        if (least < best->squared - 3.0 * best->slack) {
            *best = pbwq__candidate_at(mesh, dim, q, at);
            return -1;
        }
        if (best->slack == 0.0 && least == best->squared) {
            return 1;
        }
    }
    for (; i < end; i++) {
        pbwq__candidate other = pbwq__candidate_at(mesh, dim, q, item[i]);
        const double gap = other.squared - best->squared, slack = other.slack + best->slack;
        if (PBW__UNLIKELY(!(gap > slack))) {
            const int order = pbwq__compare(mesh, q, &other, best);
            equal |= order == 0;
            *best = order < 0 ? other : *best;
        }
    }
    return best->vertex == from ? equal : -1;
}

/* Adds a vertex to scratch->seen.  Returns whether it is new there; 0 too if memory is short. */
PBW__INLINE int pbwq__is_new(pbwq__scratch *scratch, pbw_index vertex)
{
    int added = 0;
    return pbwq__set_add(scratch, &scratch->seen, vertex, 0, &added) != NULL && added;
}

static void pbwq__heap_push(const pbw_mesh *mesh, pbwq__scratch *scratch, const double *q,
                            const pbwq__candidate *candidate)
{
    size_t at = scratch->found_count;
    if (!pbwq__room(scratch, &scratch->found, &scratch->found_capacity, at + 1, sizeof(pbwq__candidate))) {
        return;
    }
    for (; at > 0 && pbwq__comes_before(mesh, q, candidate, scratch->found + (at - 1) / 2); at = (at - 1) / 2) {
        scratch->found[at] = scratch->found[(at - 1) / 2];
    }
    scratch->found[at] = *candidate;
    scratch->found_count++;
}

/* Removes and returns the nearest of a heap that is not empty. */
static pbwq__candidate pbwq__heap_pop(const pbw_mesh *mesh, pbwq__scratch *scratch, const double *q)
{
    const pbwq__candidate first = scratch->found[0], moving = scratch->found[--scratch->found_count];
    size_t at = 0, child;
    while ((child = 2 * at + 1) < scratch->found_count) {
        child += child + 1 < scratch->found_count
              && pbwq__comes_before(mesh, q, scratch->found + child + 1, scratch->found + child);
        if (!pbwq__comes_before(mesh, q, scratch->found + child, &moving)) {
            break;
        }
        scratch->found[at] = scratch->found[child];
        at = child;
    }
    scratch->found[at] = moving;
    return first;
}

/* Puts `start` and the vertices connected to it into the heap: radius < 0: through vertices as near as it; else
   through vertices within the radius. */
static void pbwq__flood(pbwq__queries *queries, pbwq__scratch *scratch, const double *q, const pbwq__candidate *start,
                        double radius)
{
    const pbw_mesh *mesh = queries->mesh;
    const size_t *first = queries->stars->first;
    size_t next, count = 1, i;
    if (!pbwq__set_clear(scratch, &scratch->seen) || !pbwq__is_new(scratch, start->vertex)
        || !pbwq__room(scratch, &scratch->list, &scratch->list_capacity, 1, sizeof(pbw_index))) {
        return;
    }
    scratch->list[0] = start->vertex;
    pbwq__heap_push(mesh, scratch, q, start);
    for (next = 0; next < count && !scratch->failed; next++) {
        for (i = first[scratch->list[next]]; i < first[scratch->list[next] + (size_t)1] && !scratch->failed; i++) {
            const pbw_index vertex = queries->stars->item[i];
            const pbwq__candidate candidate = pbwq__candidate_at(mesh, mesh->dim, q, vertex);
            if ((radius < 0.0 ? pbwq__compare(mesh, q, &candidate, start) == 0
                              : pbwq__is_within(mesh, q, &candidate, radius))
                && pbwq__is_new(scratch, vertex)
                && pbwq__room(scratch, &scratch->list, &scratch->list_capacity, count + 1, sizeof(pbw_index))) {
                scratch->list[count++] = vertex;
                pbwq__heap_push(mesh, scratch, q, &candidate);
            }
        }
        if (next % 4096 == 4095 && pbw__report(&queries->context, 0.0)) {
            return;
        }
    }
}

/* Moves an entry of the list past others that are nearly as near, to its index in exact order, which is returned. */
static PBW__NOINLINE size_t pbwq__near_settle(const pbw_mesh *mesh, pbwq__scratch *scratch, const double *q,
                                              size_t at)
{
    pbwq__candidate *list = scratch->found;
    const pbwq__candidate moving = list[at];
    for (; at > 0 && pbwq__comes_before(mesh, q, &moving, list + at - 1); at--) {
        list[at] = list[at - 1];
    }
    for (; at < scratch->found_count && pbwq__comes_before(mesh, q, list + at + 1, &moving); at++) {
        list[at] = list[at + 1];
    }
    list[at] = moving;
    return at;
}

/* Inserts a vertex that is not in scratch->found into the list there: `most` vertices at most, in exact order, and
   room for one more.  Returns its index, `most` if it is too far.  It comes behind the last square not larger.
   If both squares next to it differ from its own by more than the slacks, this index is exact, as all others lie
   beyond these two; otherwise pbwq__near_settle moves it. */
PBW__INLINE size_t pbwq__offer_near(const pbw_mesh *mesh, pbwq__scratch *scratch, const double *q,
                                    const pbwq__candidate *candidate, size_t most)
{
    pbwq__candidate *list = scratch->found;
    const size_t count = scratch->found_count;
    size_t at = count;
    for (; at > 0 && (list[at - 1].squared > candidate->squared
                      || (list[at - 1].squared == candidate->squared
                          && list[at - 1].vertex > candidate->vertex)); at--) {
        list[at] = list[at - 1];
    }
    list[at] = *candidate;
    if (PBW__UNLIKELY((at > 0 && !(candidate->squared - list[at - 1].squared > candidate->slack + list[at - 1].slack))
                      || (at < count
                          && !(list[at + 1].squared - candidate->squared > candidate->slack + list[at + 1].slack)))
        && !(candidate->slack == 0.0)) {
        at = pbwq__near_settle(mesh, scratch, q, at);
    }
    scratch->found_count += count < most;
    return at;
}

/* Returns a limit: vertices with larger squares are not among the k nearest.  With weights there is none. */
PBW__INLINE double pbwq__near_limit(const pbwq__queries *queries, const pbwq__scratch *scratch)
{
    return queries->mesh->weights == NULL && scratch->found_count == queries->k
         ? pbwq__square_limit(scratch->found + queries->k - 1) : HUGE_VAL;
}

/* Completes the k <= PBWQ__NEAR_LIST nearest in scratch->found by the neighbours of those that are in it. */
PBW__INLINE void pbwq__near_few(pbwq__queries *queries, pbwq__scratch *scratch, const double *q, int dim)
{
    const pbw_mesh *mesh = queries->mesh;
    const size_t *first = queries->stars->first, k = queries->k;
    size_t next = 0, i;
    while (next < scratch->found_count && next + 1 < k) {
        size_t least = next + 1, j;
        const pbw_index vertex = scratch->found[next].vertex;
        double limit;
        if (scratch->found[next].done) {
            next++;
            continue;
        }
        scratch->found[next].done = 1;
        limit = pbwq__near_limit(queries, scratch);
        for (i = first[vertex]; i < first[vertex + (size_t)1]; i++) {
            const pbw_index other = queries->stars->item[i];
            const double squared = pbw__squared(mesh->points + other * (size_t)dim, q, dim);
            if (squared > limit) {
                continue;
            }
            for (j = 0; j < scratch->found_count && scratch->found[j].vertex != other; j++) {
            }
            if (j == scratch->found_count) {
                const pbwq__candidate candidate = pbwq__candidate_of(mesh, q, squared, other);
                j = pbwq__offer_near(mesh, scratch, q, &candidate, k);
                least = j < least ? j : least;
                limit = pbwq__near_limit(queries, scratch);
            }
        }
        next = least;
    }
}

PBW__INLINE void pbwq__write_near(pbwq__queries *queries, const double *q, size_t query, size_t at,
                                  const pbwq__candidate *candidate)
{
    const size_t to = query * queries->k + at;
    queries->vertices[to] = candidate != NULL ? candidate->vertex : PBW_NONE;
    if (queries->distances != NULL) {
        queries->distances[to] = candidate != NULL ? pbwq__distance_of(queries->mesh, q, candidate) : HUGE_VAL;
    }
}

/* Writes the k <= PBWQ__NEAR_LIST nearest, which scratch->found has in order, to the caller's arrays. */
static void pbwq__write_list(pbwq__queries *queries, const pbwq__scratch *scratch, const double *q, size_t query)
{
    size_t at;
    for (at = 0; at < queries->k; at++) {
        pbwq__write_near(queries, q, query, at, at < scratch->found_count ? scratch->found + at : NULL);
    }
}

/* Writes the k nearest, in order: the heap holds the nearest ones at first, and gets the neighbours of each vertex
   that leaves it. */
static void pbwq__near_many(pbwq__queries *queries, pbwq__scratch *scratch, const double *q, size_t query)
{
    const pbw_mesh *mesh = queries->mesh;
    const size_t *first = queries->stars->first;
    size_t at, i;
    for (at = 0; at < queries->k && !scratch->failed; at++) {
        if (scratch->found_count == 0) {
            pbwq__write_near(queries, q, query, at, NULL);
        } else {
            const pbwq__candidate best = pbwq__heap_pop(mesh, scratch, q);
            pbwq__write_near(queries, q, query, at, &best);
            for (i = first[best.vertex]; i < first[best.vertex + (size_t)1]; i++) {
                if (pbwq__is_new(scratch, queries->stars->item[i])) {
                    const pbwq__candidate candidate = pbwq__candidate_at(mesh, mesh->dim, q, queries->stars->item[i]);
                    pbwq__heap_push(mesh, scratch, q, &candidate);
                }
            }
        }
        if (at % 4096 == 4095 && pbw__report(&queries->context, 0.0)) {
            return;
        }
    }
}

/* Sets *start to the lowest of the vertices as near as it.  Returns 0 if these are more than PBWQ__NEAR_LIST. */
PBW__INLINE int pbwq__lowest_of_few(const pbwq__queries *queries, const double *q, pbwq__candidate *start, int dim)
{
    const pbw_mesh *mesh = queries->mesh;
    const pbw_lists *stars = queries->stars;
    const double limit = mesh->weights == NULL ? pbwq__square_limit(start) : HUGE_VAL;
    pbw_index list[PBWQ__NEAR_LIST], near_ones[PBWQ__NEAR_LIST];
    size_t count = 1, next, i, j;
    list[0] = start->vertex;
    for (next = 0; next < count; next++) {
        const size_t end = stars->first[list[next] + (size_t)1];
        for (i = stars->first[list[next]]; i < end; ) {
            const size_t stop = end - i < PBWQ__NEAR_LIST ? end : i + PBWQ__NEAR_LIST;
            size_t found = 0;
            for (; i < stop; i++) {                  /* branchless: unpredictable */
                near_ones[found] = stars->item[i];
                found += pbw__squared(mesh->points + stars->item[i] * (size_t)dim, q, dim) <= limit;
            }
            while (found-- > 0) {
                const pbwq__candidate candidate = pbwq__candidate_at(mesh, dim, q, near_ones[found]);
                for (j = 0; j < count && list[j] != candidate.vertex; j++) {
                }
                if (j < count || pbwq__compare(mesh, q, &candidate, start) != 0) {
                    continue;
                }
                if (count == PBWQ__NEAR_LIST) {
                    return 0;
                }
                list[count++] = candidate.vertex;
            }
        }
    }
    for (i = 1; i < count; i++) {
        start->vertex = list[i] < start->vertex ? list[i] : start->vertex;
    }
    return 1;
}

/* Answers one query, given a nearest vertex; equal: others are as near. */
static void pbwq__near_one(pbwq__queries *queries, pbwq__scratch *scratch, const double *q, size_t query,
                           const pbwq__candidate *best, int equal)
{
    const pbw_mesh *mesh = queries->mesh;
    pbwq__candidate lowest[PBWQ__NEAR_LIST];
    size_t count = 1;
    lowest[0] = *best;
    if (equal && queries->k == 1) {
        equal = !PBW__BY_DIM(mesh->dim, pbwq__lowest_of_few, queries, q, lowest);
    }
    if (!equal && queries->k == 1) {
        pbwq__write_near(queries, q, query, 0, lowest);
        return;
    }
    if (equal || queries->k > PBWQ__NEAR_LIST) {
        pbwq__flood(queries, scratch, q, best, -1.0);
        if (queries->k > PBWQ__NEAR_LIST) {
            pbwq__near_many(queries, scratch, q, query);
            return;
        }
        for (count = 0; count < queries->k && scratch->found_count > 0; count++) {
            lowest[count] = pbwq__heap_pop(mesh, scratch, q);
        }
    }
    if (pbwq__room(scratch, &scratch->found, &scratch->found_capacity, PBWQ__NEAR_LIST + 1,
                   sizeof(pbwq__candidate))) {
        memcpy(scratch->found, lowest, count * sizeof(lowest[0]));
        scratch->found_count = count;
        PBW__BY_DIM(mesh->dim, pbwq__near_few, queries, scratch, q);
        pbwq__write_list(queries, scratch, q, query);
    }
}

/* Without simplices: puts all canonical points, or those within a radius >= 0, into the heap. */
static void pbwq__push_all(pbwq__queries *queries, pbwq__scratch *scratch, const double *q, double radius)
{
    const pbw_mesh *mesh = queries->mesh;
    size_t v;
    for (v = 0; v < mesh->point_count && !scratch->failed; v++) {
        const pbwq__candidate candidate = pbwq__candidate_at(mesh, mesh->dim, q, (pbw_index)v);
        if (v % PBW__TICK == 0 && pbw__report(&queries->context, 0.0)) {
            return;
        }
        if (mesh->canonical[v] == v && (radius < 0.0 || pbwq__is_within(mesh, q, &candidate, radius))) {
            pbwq__heap_push(mesh, scratch, q, &candidate);
        }
    }
}

/* Sets q[3], the relative error of squares. */
PBW__INLINE void pbwq__set_error(const pbwq__queries *queries, double *q)
{
    const double large = queries->large, limit = large / 805306368.0;        /* 2^23 units */
    int fits = large > 0.0, k;
    for (k = 0; k < 3; k++) {
        fits &= (pbw__abs(q[k]) <= limit) & ((large + q[k]) - large == q[k]);
    }
    q[3] = fits ? 0.0 : PBW__REACH_ERROR * DBL_EPSILON;
}

/* Reads the i-th query along the curve. */
PBW__INLINE void pbwq__query_at(const pbwq__queries *queries, size_t i, double *q)
{
    pbw__fetch(&queries->input, pbwq__query_of(queries, i), q);
    pbwq__set_error(queries, q);
}

/* Sets *best to a nearest vertex of q, by steps from *best, or at the start of a block from a guess. */
static void pbwq__query_descend(const pbwq__queries *queries, int start, const double *q, pbwq__candidate *best)
{
    const pbw_mesh *mesh = queries->mesh;
    *best = pbwq__candidate_at(mesh, mesh->dim, q, start ? pbwq__start_vertex(mesh, q) : best->vertex);
    while (PBW__BY_DIM(mesh->dim, pbwq__descend, queries, q, best) < 0) {
    }
}

PBW__INLINE void pbwq__nearest_turn(pbwq__queries *queries, pbwq__scratch *scratch, pbwq__lane *lane, int several,
                                    int dim)
{
    const pbw_mesh *mesh = queries->mesh;
    const pbw_lists *stars = queries->stars;
    int equal;
    if (pbwq__lane_reads(queries, lane)) {
        pbwq__set_error(queries, lane->q);
        lane->best = pbwq__candidate_at(mesh, dim, lane->q, lane->best.vertex);
    }
    if (several && lane->fetched < 2) {
        size_t i = stars->first[lane->best.vertex];
        const size_t end = stars->first[lane->best.vertex + (size_t)1];
        if (lane->fetched++ == 0) {
            PBW__PREFETCH(stars->item + i);
            PBW__PREFETCH(stars->item + end - 1);
            return;
        }
        for (; i < end; i++) {
            PBW__PREFETCH(mesh->points + stars->item[i] * (size_t)dim);
        }
        return;
    }
    while ((equal = pbwq__descend(queries, lane->q, &lane->best, dim)) < 0) {
        if (several) {
            PBW__PREFETCH(stars->first + lane->best.vertex);
            lane->fetched = 0;
            return;
        }
    }
    scratch->found_count = 0;
    pbwq__near_one(queries, scratch, lane->q, pbwq__query_of(queries, lane->next), &lane->best, equal);
    pbwq__lane_ends(lane);
}

/* In small meshes, and where points are along the curve, one search after the other takes less time. */
static void pbwq__nearest_block(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t from, size_t to)
{
    const pbw_mesh *mesh = queries->mesh;
    const int few = mesh->simplex_count < 16384 || mesh->original != NULL;
    pbwq__lane lane[PBWQ__LANES];
    (void)block;
    if (mesh->simplex_count == 0) {
        for (; from < to && !scratch->failed; from++) {
            double q[4];
            pbwq__query_at(queries, from, q);
            scratch->found_count = 0;
            pbwq__push_all(queries, scratch, q, -1.0);
            pbwq__near_many(queries, scratch, q, pbwq__query_of(queries, from));
        }
        return;
    }
    pbwq__lanes_start(queries, lane, few ? 1 : PBWQ__LANES, from, to);
    if (few) {
        PBW__BY_DIM(mesh->dim, pbwq__take_turns, queries, scratch, lane, 1, pbwq__nearest_turn);
    } else {
        PBW__BY_DIM(mesh->dim, pbwq__take_turns, queries, scratch, lane, PBWQ__LANES, pbwq__nearest_turn);
    }
}

/* Returns whether these may be the stars of the mesh.  NULL may: we make them. */
PBW__INLINE int pbwq__fits(const pbw_mesh *mesh, const pbw_lists *stars)
{
    return stars == NULL || mesh == NULL || (stars->count == mesh->point_count && stars->first != NULL);
}

/* Uses the caller's stars, or makes the stars of the mesh. */
static pbw_status pbwq__take_stars(pbwq__queries *queries, const pbw_lists *stars)
{
    const pbw_mesh *mesh = queries->mesh;
    queries->stars = stars != NULL ? stars : &queries->own_stars;
    return stars != NULL ? PBW_OK
         : pbwq__make_lists(queries, pbwq__stars_block, mesh->simplex_count, 4096, mesh->point_count,
                            &queries->own_stars);
}

static void pbwq__within_block(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t from, size_t to)
{
    const pbw_mesh *mesh = queries->mesh;
    pbwq__candidate best;
    double q[4], *values;
    pbw_index *items;
    size_t i, k, count;
    memset(&best, 0, sizeof(best));
    for (i = from; i < to && !scratch->failed; i++) {
        pbwq__query_at(queries, i, q);
        scratch->found_count = 0;
        if (mesh->simplex_count == 0) {
            pbwq__push_all(queries, scratch, q, queries->radius);
        } else {
            pbwq__query_descend(queries, i == from, q, &best);
            if (pbwq__is_within(mesh, q, &best, queries->radius)) {
                pbwq__flood(queries, scratch, q, &best, queries->radius);
            }
        }
        count = scratch->found_count;
        items = scratch->failed ? NULL
              : pbwq__chunk_add(queries, scratch, block, pbwq__query_of(queries, i), count, &values);
        for (k = 0; k < count && items != NULL; k++) {
            const pbwq__candidate candidate = pbwq__heap_pop(mesh, scratch, q);
            items[k] = candidate.vertex;
            values[k] = pbwq__distance_of(mesh, q, &candidate);
        }
        if (pbw__report(&queries->context, 0.0)) {
            return;
        }
    }
}

PBWDEF pbw_status pbw_within(const pbw_mesh *mesh, const pbw_lists *stars, const double *points, size_t count,
                             double radius, const pbw_options *options, pbw_lists *lists)
{
    pbwq__queries queries;
    pbw_status status;
    if (lists == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(lists, 0, sizeof(*lists));
    if (!(radius >= 0.0 && radius <= DBL_MAX) || !pbwq__fits(mesh, stars)) {
        return PBW_ERROR_ARGUMENT;
    }
    status = pbwq__queries_start(&queries, mesh, points, count, options);
    status = status == PBW_OK ? pbwq__take_stars(&queries, stars) : status;
    if (status == PBW_OK) {
        queries.radius = radius;
        queries.with_values = 1;
        status = pbwq__make_lists(&queries, pbwq__within_block, count, PBWQ__BLOCK_QUERIES, count, lists);
    }
    return pbwq__lists_end(&queries, status, lists);
}
/* ------------------------------------------------------------------------------------------------------
   >>boxes        Many nearest vertices, by a tree of boxes.
   In: a mesh, queries.  Out: for each query the k nearest vertices in exact order.
   Holds: a search with a limit meets all vertices with squares not larger: it skips a box only if the square of its
   distance is larger, and this is computed by the operations of pbw__squared from differences that are not larger
   than those of any vertex in the box; rounding keeps the order.  The answer is complete if the limit reaches
   pbwq__square_limit of the farthest.

   Eight successive vertices on the curve are a leaf, eight leaves a node, eight nodes a node of the next level.
   Successive queries share a list of the leaves near the box around them, likewise by differences that are not larger
   than theirs.  Each query picks leaves from the list, and then the vertices in a ball that is likely to hold k of
   them, by the answer to the query before: by vectors, without branches.  Sorted by their squares, k vertices or more
   are the answer, but for ties, which pbwq__offer_near settles.  Fewer vertices: a wider ball.  Without vectors, with
   weights, and for few queries >>nearest searches the mesh itself, with the same answers.
   ------------------------------------------------------------------------------------------------------ */
#ifdef PBW__SIMD
#define PBWQ__BRANCH 8
#define PBWQ__TREE_LEVELS 11                          /* 8^11 leaves: more than there can be */

struct pbwq__tree {
    size_t count, groups;                            /* vertices; groups of eight nodes */
    int top;                                         /* the level that is one group; leaves are level 0 */
    size_t nodes[PBWQ__TREE_LEVELS], first[PBWQ__TREE_LEVELS];     /* per level: its nodes, its first group */
    pbw_index *vertex;                               /* along the curve */
    double *coordinate;                              /* per leaf and axis, eight */
    double *box;                                     /* per group and axis, eight low ends, then eight high ends */
};

#define PBWQ__BUNCH 8                                 /* up to so many queries share a list */
#define PBWQ__LISTED 160                              /* up to so many leaves are in a list */
#define PBWQ__GATHERED 168                            /* 2 PBWQ__NEAR_LIST + 24 vertices, and those of two leaves */

/* The search of a block of queries. */
typedef struct pbwq__search {
    pbw__order4 pack[16];                            /* for each set of lanes the order that has these first */
    size_t bunch;                                    /* how many of the next queries try to share a list */
    double query[PBWQ__BUNCH][4];
    double reach;                                    /* a square that is likely to hold k vertices */
    double low[3], high[3];                          /* the box of all vertices */
    double listed;                                   /* the square that the list reaches; 0: no list is shared */
    size_t height, leaves, count;
    uint64_t stack[(PBWQ__TREE_LEVELS + 1) * PBWQ__BRANCH];     /* nodes to look into: level << 32 | node */
    double leaf[PBWQ__LISTED], end[6][PBWQ__LISTED];     /* the list; the low end and the high end on each axis */
    double squared[PBWQ__GATHERED];                  /* of the vertices gathered, */
    double slot[PBWQ__GATHERED];                     /* and their numbers along the curve */
} pbwq__search;

/* Returns where the low end of a node's box on the first axis is.  The high end is 8 entries further on, the low end
   on the next axis 16. */
PBW__INLINE double *pbwq__tree_box(const pbwq__tree *tree, int dim, int level, size_t node)
{
    return tree->box + (tree->first[level] + node / PBWQ__BRANCH) * 2 * PBWQ__BRANCH * (size_t)dim
         + node % PBWQ__BRANCH;
}

/* Sets the ends of a box on one axis to the least of `count` low ends and the largest of the high ends. */
PBW__INLINE void pbwq__tree_ends(double *end, const double *low, const double *high, size_t count)
{
    size_t i;
    end[0] = HUGE_VAL;
    end[PBWQ__BRANCH] = -HUGE_VAL;
    for (i = 0; i < count; i++) {
        end[0] = low[i] < end[0] ? low[i] : end[0];
        end[PBWQ__BRANCH] = high[i] > end[PBWQ__BRANCH] ? high[i] : end[PBWQ__BRANCH];
    }
}

/* Fills leaves and their boxes.  The last leaf is filled up with points at infinity. */
static pbw_status pbwq__tree_leaves(void *arg, size_t from, size_t to)
{
    const pbwq__queries *queries = (const pbwq__queries *)arg;
    const pbwq__tree *tree = queries->tree;
    const size_t dim = (size_t)queries->mesh->dim;
    size_t leaf, i, k;
    for (leaf = from; leaf < to; leaf++) {
        double *box = pbwq__tree_box(tree, (int)dim, 0, leaf);
        const size_t rest = tree->count - leaf * PBWQ__BRANCH, count = rest < PBWQ__BRANCH ? rest : PBWQ__BRANCH;
        for (k = 0; k < dim; k++) {
            double *c = tree->coordinate + (leaf * dim + k) * PBWQ__BRANCH;
            for (i = 0; i < PBWQ__BRANCH; i++) {
                const size_t vertex = tree->vertex[leaf * PBWQ__BRANCH + (i < count ? i : 0)];
                c[i] = i < count ? queries->mesh->points[vertex * dim + k] : HUGE_VAL;
            }
            pbwq__tree_ends(box + k * 2 * PBWQ__BRANCH, c, c, count);
        }
    }
    return PBW_OK;
}

/* Computes the boxes of a level above the leaves. */
static void pbwq__tree_level(const pbwq__tree *tree, int dim, int level)
{
    size_t node;
    int k;
    for (node = 0; node < tree->nodes[level]; node++) {
        double *box = pbwq__tree_box(tree, dim, level, node);
        const double *below = pbwq__tree_box(tree, dim, level - 1, node * PBWQ__BRANCH);
        const size_t rest = tree->nodes[level - 1] - node * PBWQ__BRANCH;
        for (k = 0; k < dim * 2 * PBWQ__BRANCH; k += 2 * PBWQ__BRANCH) {
            pbwq__tree_ends(box + k, below + k, below + k + PBWQ__BRANCH, rest < PBWQ__BRANCH ? rest : PBWQ__BRANCH);
        }
    }
}

/* Lists the vertices, or the canonical points of a degenerate mesh, along the curve. */
static pbw_status pbwq__tree_vertices(pbwq__queries *queries, pbwq__tree *tree)
{
    const pbw_mesh *mesh = queries->mesh;
    pbw__input input = pbw__input_of(mesh->dim, 0, mesh->points, NULL, mesh->point_count);
    pbw__vertices sorted;
    pbw_status status = PBW_OK;
    size_t i;
    memset(&sorted, 0, sizeof(sorted));
    input.stride = (size_t)mesh->dim * sizeof(double);
    if (mesh->original == NULL) {                    /* else the points are along the curve already */
        status = pbwq__sort_points(&queries->context, &input, &sorted);
    }
    for (i = 0; i < mesh->point_count && status == PBW_OK; i++) {
        const size_t v = sorted.id != NULL ? sorted.id[i + 1] : i;
        if (mesh->simplex_count > 0 ? mesh->incident[v] != PBW_NONE : mesh->canonical[v] == v) {
            tree->vertex[tree->count++] = (pbw_index)v;
        }
    }
    pbw__vertices_free(&queries->context, &sorted);
    return status;
}

/* Allocates leaves and the boxes of all levels.  Returns 0 if memory is short. */
static int pbwq__tree_room(pbw_memory *memory, pbwq__tree *tree, int dim)
{
    const size_t leaves = (tree->count + PBWQ__BRANCH - 1) / PBWQ__BRANCH;
    int level = 0;
    tree->nodes[0] = leaves;
    for (; tree->nodes[level] > PBWQ__BRANCH; level++) {
        tree->nodes[level + 1] = (tree->nodes[level] + PBWQ__BRANCH - 1) / PBWQ__BRANCH;
        tree->first[level + 1] = tree->first[level] + tree->nodes[level + 1];
    }
    tree->top = level;
    tree->groups = tree->first[level] + 1;
    tree->coordinate = (double *)pbw__allocate(memory, leaves * PBWQ__BRANCH * (size_t)dim, sizeof(double));
    tree->box = (double *)pbw__allocate(memory, tree->groups * 2 * PBWQ__BRANCH * (size_t)dim, sizeof(double));
    if (tree->coordinate == NULL || tree->box == NULL) {
        return 0;
    }
    memset(tree->box, 0, tree->groups * 2 * PBWQ__BRANCH * (size_t)dim * sizeof(double));
    return 1;
}

static pbw_status pbwq__tree_build(pbwq__queries *queries, pbwq__tree *tree)
{
    const pbw_mesh *mesh = queries->mesh;
    pbw_memory *memory = &queries->context.memory;
    pbw_status status;
    int level;
    tree->vertex = (pbw_index *)pbw__allocate(memory, mesh->point_count, sizeof(pbw_index));
    if (tree->vertex == NULL) {
        return PBW_ERROR_MEMORY;
    }
    status = pbwq__tree_vertices(queries, tree);
    if (status == PBW_OK && !pbwq__tree_room(memory, tree, mesh->dim)) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        status = pbw__for_range(&queries->context, tree->nodes[0], 1024, 0.1, pbwq__tree_leaves, queries);
    }
    for (level = 1; status == PBW_OK && level <= tree->top; level++) {
        pbwq__tree_level(tree, mesh->dim, level);
    }
    return status;
}

/* ---- searches */
/* Stores the lanes of a set, packed, and then others. */
PBW__SIMD_INLINE void pbwq__pack(const pbwq__search *search, double *to, pbw__d4 x, unsigned set)
{
    const pbw__d4 packed = pbw__reorder(x, search->pack[set]);
    memcpy(to, &packed, sizeof(packed));
}

/* Fills `place`: the numbers of the gathered vertices sorted by their squares.  The place of each is the number of
   smaller squares and of equal ones before it. */
PBW__SIMD_INLINE void pbwq__search_sort(pbwq__search *search, unsigned *place)
{
    static const int64_t later[7] = { 0, 0, 0, 0, -1, -1, -1 };
    const size_t count = search->count;
    double *squared = search->squared;
    size_t i, j;
    for (i = count; i % 4 != 0; i++) {
        squared[i] = HUGE_VAL;
    }
    for (i = 0; i < count; i += 4) {
        const pbw__d4 own = pbw__load4d(squared + i);
        pbw__l4 before = (pbw__l4)pbw__splat(0.0);
        int64_t number[4];
        for (j = 0; j < i; j++) {
            before -= (pbw__l4)pbw__at_least(own, pbw__splat(squared[j]));
        }
        for (j = 0; j < 4; j++) {
            const pbw__d4 other = pbw__splat(squared[i + j]);
            const pbw__d4 equal = pbw__and4(pbw__mask(later + 3 - j), pbw__equal(own, other));
            before -= (pbw__l4)pbw__or4(pbw__greater(own, other), equal);
        }
        for (j = i + 4; j < count; j++) {
            before -= (pbw__l4)pbw__greater(own, pbw__splat(squared[j]));
        }
        memcpy(number, &before, sizeof(number));
        for (j = 0; j < 4 && i + j < count; j++) {
            place[number[j]] = (unsigned)(i + j);
        }
    }
}

/* Puts the k nearest of the gathered vertices, or all of them, into scratch->found, in exact order. */
PBW__SIMD_INLINE void pbwq__search_settle(const pbwq__queries *queries, pbwq__scratch *scratch, const double *q,
                                          pbwq__search *search)
{
    const pbwq__tree *tree = queries->tree;
    unsigned place[PBWQ__GATHERED];
    size_t i;
    pbwq__search_sort(search, place);
    scratch->found_count = 0;
    for (i = 0; i < search->count; i++) {
        const size_t slot = (size_t)search->slot[place[i]];
        const double squared = search->squared[place[i]];
        if (squared > pbwq__near_limit(queries, scratch)) {
            break;
        }
        if (slot < tree->count) {
            pbwq__candidate candidate = pbwq__candidate_of(queries->mesh, q, squared, tree->vertex[slot]);
            candidate.done = (pbw_index)slot;
            (void)pbwq__offer_near(queries->mesh, scratch, q, &candidate, queries->k);
        }
    }
}

/* Keeps the k nearest of the gathered vertices.  Returns their limit. */
PBW__SIMD static PBW__NOINLINE double pbwq__search_trim(const pbwq__queries *queries, pbwq__scratch *scratch,
                                                        pbwq__search *search, const double *q)
{
    size_t i;
    pbwq__search_settle(queries, scratch, q, search);
    for (i = 0; i < scratch->found_count; i++) {
        search->squared[i] = scratch->found[i].squared;
        search->slot[i] = (double)scratch->found[i].done;
    }
    search->count = scratch->found_count;
    return pbwq__near_limit(queries, scratch);
}

/* Adds the squares of how far four boxes are from the interval low, high on one axis. */
PBW__SIMD_INLINE pbw__d4 pbwq__add_away(pbw__d4 sum, const double *low_ends, const double *high_ends, double low,
                                        double high)
{
    const pbw__d4 below = pbw__load4d(low_ends) - pbw__splat(high), above = pbw__splat(low) - pbw__load4d(high_ends);
    const pbw__d4 away = pbw__max4(pbw__max4(below, above), pbw__splat(0.0));
    return sum + away * away;
}

/* Goes on to list the leaves with a square of at most `most` from the box low, high, as long as there is room. */
PBW__SIMD_INLINE void pbwq__search_list(const pbwq__tree *tree, pbwq__search *search, const double *low,
                                        const double *high, double most, int dim)
{
    const pbw__d4 limit = pbw__splat(most), number = pbw__four(0.0, 1.0, 2.0, 3.0);
    size_t height = search->height, leaves = search->leaves, i;
    while (height > 0 && leaves <= PBWQ__LISTED - PBWQ__BRANCH) {
        const uint64_t at = search->stack[--height];
        const int level = (int)(at >> 32) - 1;
        const size_t node = (at & 0xffffffffu) * PBWQ__BRANCH, rest = tree->nodes[level] - node;
        const double *box = pbwq__tree_box(tree, dim, level, node);
        unsigned half;
        int k;
        for (half = 0; half < PBWQ__BRANCH; half += 4) {
            pbw__d4 sum = pbw__splat(0.0);
            unsigned set = pbw__first_lanes(rest < half ? 0 : rest - half < 4 ? (unsigned)(rest - half) : 4);
            for (k = 0; k < dim; k++) {
                const double *from = box + k * 2 * PBWQ__BRANCH + half;
                sum = pbwq__add_away(sum, from, from + PBWQ__BRANCH, low[k], high[k]);
            }
            set &= pbw__signs(pbw__at_least(limit, sum));
            if (level > 0) {
                for (i = 0; i < 4; i++) {
                    search->stack[height] = (uint64_t)level << 32 | (node + half + i);
                    height += set >> i & 1;
                }
                continue;
            }
            pbwq__pack(search, search->leaf + leaves, number + pbw__splat((double)(node + half)), set);
            for (k = 0; k < dim; k++) {
                const double *from = box + k * 2 * PBWQ__BRANCH + half;
                pbwq__pack(search, search->end[2 * k] + leaves, pbw__load4d(from), set);
                pbwq__pack(search, search->end[2 * k + 1] + leaves, pbw__load4d(from + PBWQ__BRANCH), set);
            }
            leaves += pbw__count4(set);
        }
    }
    search->height = height;
    search->leaves = leaves;
}

PBW__INLINE void pbwq__search_restart(const pbwq__tree *tree, pbwq__search *search)
{
    search->height = 1;
    search->leaves = 0;
    search->stack[0] = (uint64_t)(tree->top + 1) << 32;
}

/* Gathers the vertices of a leaf with squares of at most `most`. */
PBW__SIMD_INLINE void pbwq__gather_leaf(const pbwq__tree *tree, pbwq__search *search, int dim, const double *q,
                                        double most, size_t leaf)
{
    const double *c = tree->coordinate + leaf * (size_t)dim * PBWQ__BRANCH;
    const pbw__d4 limit = pbw__splat(most), number = pbw__four(0.0, 1.0, 2.0, 3.0);
    unsigned half;
    for (half = 0; half < PBWQ__BRANCH; half += 4) {
        const pbw__d4 x = pbw__load4d(c + half) - pbw__splat(q[0]);
        const pbw__d4 y = pbw__load4d(c + half + PBWQ__BRANCH) - pbw__splat(q[1]);
        pbw__d4 sum = x * x + y * y;
        unsigned set;
        if (dim == 3) {
            const pbw__d4 z = pbw__load4d(c + half + 2 * PBWQ__BRANCH) - pbw__splat(q[2]);
            sum = sum + z * z;
        }
        set = pbw__signs(pbw__at_least(limit, sum));
        pbwq__pack(search, search->squared + search->count, sum, set);
        pbwq__pack(search, search->slot + search->count,
                   number + pbw__splat((double)(leaf * PBWQ__BRANCH + half)), set);
        search->count += pbw__count4(set);
    }
}

/* Gathers the vertices of listed leaves with squares of at most `most`.  Whenever there is no room, it keeps the k
   nearest, and goes on with their limit.  Returns the last limit. */
PBW__SIMD_INLINE double pbwq__search_gather(const pbwq__queries *queries, pbwq__scratch *scratch,
                                            pbwq__search *search, const double *q, double most, int dim)
{
    double leaf[PBWQ__LISTED];
    size_t count = 0, i;
    int k;
    for (i = 0; i < search->leaves; i += 4) {
        pbw__d4 sum = pbw__splat(0.0);
        unsigned set = pbw__first_lanes((unsigned)(search->leaves - i));
        for (k = 0; k < dim; k++) {
            sum = pbwq__add_away(sum, search->end[2 * k] + i, search->end[2 * k + 1] + i, q[k], q[k]);
        }
        set &= pbw__signs(pbw__at_least(pbw__splat(most), sum));
        pbwq__pack(search, leaf + count, pbw__load4d(search->leaf + i), set);
        count += pbw__count4(set);
    }
    for (i = 0; i < count; i++) {
        pbwq__gather_leaf(queries->tree, search, dim, q, most, (size_t)leaf[i]);
        if (PBW__UNLIKELY(search->count > 2 * queries->k + 24)) {
            most = pbwq__search_trim(queries, scratch, search, q);
        }
    }
    return most;
}

/* Gathers all vertices with squares of at most `most`, with a list of the query's own, in parts if it is long. */
PBW__SIMD_INLINE double pbwq__search_alone(pbwq__queries *queries, pbwq__scratch *scratch, pbwq__search *search,
                                           const double *q, double most, int dim)
{
    search->listed = 0.0;
    search->count = 0;
    pbwq__search_restart(queries->tree, search);
    while (search->height > 0) {
        search->leaves = 0;
        pbwq__search_list(queries->tree, search, q, q, most, dim);
        most = pbwq__search_gather(queries, scratch, search, q, most, dim);
        if (search->height > 0 && pbw__report(&queries->context, 0.0)) {
            break;
        }
    }
    return most;
}

/* Puts k successive vertices, or all, from the leaf that is reached by near boxes into scratch->found. */
static void pbwq__search_start(const pbwq__queries *queries, pbwq__scratch *scratch, const double *q)
{
    const pbwq__tree *tree = queries->tree;
    const size_t dim = (size_t)queries->mesh->dim, count = queries->k < tree->count ? queries->k : tree->count;
    size_t node = 0, i, k;
    int level;
    for (level = tree->top; level >= 0; level--) {
        const size_t first = node * PBWQ__BRANCH;
        double least = HUGE_VAL;
        node = first;
        for (i = first; i < first + PBWQ__BRANCH && i < tree->nodes[level]; i++) {
            const double *box = pbwq__tree_box(tree, (int)dim, level, i);
            double sum = 0.0;
            for (k = 0; k < dim; k++, box += 2 * PBWQ__BRANCH) {
                const double away = pbw__max(pbw__max(box[0] - q[k], q[k] - box[PBWQ__BRANCH]), 0.0);
                sum += away * away;
            }
            node = sum < least ? i : node;
            least = sum < least ? sum : least;
        }
    }
    node *= PBWQ__BRANCH;
    node = node < tree->count - count ? node : tree->count - count;
    for (i = 0; i < count; i++) {
        scratch->found[i].vertex = tree->vertex[node + i];
    }
    scratch->found_count = count;
}

/* Returns a limit for the squares of the k nearest, from the farthest of k vertices in scratch->found. */
PBW__SIMD_INLINE double pbwq__search_limit(const pbwq__queries *queries, int dim, const pbwq__scratch *scratch,
                                           const double *q)
{
    pbwq__candidate farthest;
    double most = 0.0;
    size_t i;
    for (i = 0; i < scratch->found_count; i++) {
        const pbw_index vertex = scratch->found[i].vertex;
        most = pbw__max(most, pbw__squared(queries->mesh->points + vertex * (size_t)dim, q, dim));
    }
    farthest = pbwq__candidate_of(queries->mesh, q, most, 0);         /* without weights it may be any vertex */
    return scratch->found_count < queries->k ? HUGE_VAL : pbwq__square_limit(&farthest);
}

/* Sets the box of all vertices. */
static void pbwq__search_box(const pbwq__tree *tree, pbwq__search *search, int dim)
{
    size_t i;
    int k;
    for (k = 0; k < dim; k++) {
        search->low[k] = HUGE_VAL;
        search->high[k] = -HUGE_VAL;
        for (i = 0; i < tree->nodes[tree->top]; i++) {
            const double *end = pbwq__tree_box(tree, dim, tree->top, i) + (size_t)k * 2 * PBWQ__BRANCH;
            search->low[k] = end[0] < search->low[k] ? end[0] : search->low[k];
            search->high[k] = end[PBWQ__BRANCH] > search->high[k] ? end[PBWQ__BRANCH] : search->high[k];
        }
    }
}

/* Returns the square of the distance of a query from the box of all vertices. */
PBW__SIMD_INLINE double pbwq__search_away(const pbwq__search *search, const double *q, int dim)
{
    double sum = 0.0;
    int k;
    for (k = 0; k < dim; k++) {
        const double away = pbw__max(pbw__max(search->low[k] - q[k], q[k] - search->high[k]), 0.0);
        sum += away * away;
    }
    return sum;
}

/* Gathers all vertices with squares up to a limit larger than `tried` that holds k of them.  Returns the limit.  It
   grows from the square of the box of all: from afar the squares of all vertices are in a short range. */
PBW__SIMD_INLINE double pbwq__search_wider(pbwq__queries *queries, pbwq__scratch *scratch, pbwq__search *search,
                                           const double *q, double tried, int dim)
{
    const double away = pbwq__search_away(search, q, dim);
    double limit, step, most;
    pbwq__search_start(queries, scratch, q);
    limit = pbwq__search_limit(queries, dim, scratch, q);
    step = pbw__max((limit - away) / 256.0, tried - away);
    do {
        step *= 2.5;
        most = away + step < limit ? away + step : limit;      /* the limit for the NaN of an overflow too */
        most = pbwq__search_alone(queries, scratch, search, q, most, dim);
    } while (search->count < queries->k && most < limit);
    return most;
}

/* Finds the k nearest of a query. */
PBW__SIMD_INLINE void pbwq__search_of(pbwq__queries *queries, pbwq__scratch *scratch, pbwq__search *search,
                                      const double *q, int dim)
{
    double most = search->reach;
    search->count = 0;
    if (search->listed > 0.0) {
        most = most < search->listed ? most : search->listed;
        most = pbwq__search_gather(queries, scratch, search, q, most, dim);
        if (search->count < queries->k) {
            search->count = 0;
            most = pbwq__search_gather(queries, scratch, search, q, search->listed, dim);
        }
    } else if (most > 2.0 * pbwq__search_away(search, q, dim)) {         /* else it may hold most vertices */
        most = pbwq__search_alone(queries, scratch, search, q, most, dim);
    } else {
        most = 0.0;
    }
    if (search->count < queries->k) {
        most = pbwq__search_wider(queries, scratch, search, q, most, dim);
    }
    pbwq__search_settle(queries, scratch, q, search);
    if (PBW__UNLIKELY(pbwq__near_limit(queries, scratch) > most)) {
        (void)pbwq__search_alone(queries, scratch, search, q, pbwq__near_limit(queries, scratch), dim);
        pbwq__search_settle(queries, scratch, q, search);
    }
    if (scratch->found_count == queries->k && scratch->found[queries->k - 1].squared > 0.0) {
        search->reach = (1.1 + 1.2 / ((double)queries->k + 0.3)) * scratch->found[queries->k - 1].squared;
    }
}

/* Reads the i-th query along the curve and those after it that share a list with it, and makes the list.  Returns the
   number of these queries. */
PBW__SIMD_INLINE size_t pbwq__search_bunch(pbwq__queries *queries, pbwq__search *search, size_t i, size_t to, int dim)
{
    double low[3] = { HUGE_VAL, HUGE_VAL, HUGE_VAL }, high[3] = { -HUGE_VAL, -HUGE_VAL, -HUGE_VAL };
    size_t count = to - i < search->bunch ? to - i : search->bunch, j;
    int k;
    for (j = 0; j < count; j++) {
        double *q = search->query[j];
        pbwq__query_at(queries, i + j, q);
        for (k = 0; k < dim; k++) {
            low[k] = q[k] < low[k] ? q[k] : low[k];
            high[k] = q[k] > high[k] ? q[k] : high[k];
        }
    }
    search->listed = 1.5 * search->reach;
    pbwq__search_restart(queries->tree, search);
    pbwq__search_list(queries->tree, search, low, high, search->listed, dim);
    if (search->height > 0) {
        search->listed = 0.0;
        search->bunch = (search->bunch + 1) / 2;
        return 1;
    }
    search->bunch += search->leaves < PBWQ__LISTED / 2 && search->bunch < PBWQ__BUNCH;
    return count;
}

PBW__SIMD static void pbwq__search_block(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t from,
                                         size_t to)
{
    pbwq__search search;
    size_t i, j, count;
    unsigned set;
    (void)block;
    if (!pbwq__room(scratch, &scratch->found, &scratch->found_capacity, PBWQ__NEAR_LIST + 1,
                    sizeof(pbwq__candidate))) {
        return;
    }
    search.reach = 0.0;
    pbwq__search_box(queries->tree, &search, queries->mesh->dim);
    search.bunch = 1;
    for (set = 0; set < 16; set++) {
        int32_t order[4] = { 0, 0, 0, 0 };
        pbw__i4 lanes;
        for (i = j = 0; i < 4; i++) {
            order[j] = (int32_t)i;
            j += set >> i & 1;
        }
        memcpy(&lanes, order, sizeof(lanes));
        search.pack[set] = pbw__order4_of(lanes);
    }
    for (i = from; i < to; i += j) {
        count = PBW__BY_DIM(queries->mesh->dim, pbwq__search_bunch, queries, &search, i, to);
        for (j = 0; j < count && (j == 0 || search.listed > 0.0); j++) {     /* pbwq__search_alone ends a list */
            const double *q = search.query[j];
            PBW__BY_DIM(queries->mesh->dim, pbwq__search_of, queries, scratch, &search, q);
#ifdef PBW__AVX2
            _mm256_zeroupper();                      /* SSE code would stall otherwise */
#endif
            pbwq__write_list(queries, scratch, q, pbwq__query_of(queries, i + j));
        }
    }
}

static pbw_status pbwq__search_all(pbwq__queries *queries)
{
    const pbw_mesh *mesh = queries->mesh;
    const size_t width = PBWQ__BRANCH * (size_t)mesh->dim;
    pbw_memory *memory = &queries->context.memory;
    pbwq__tree tree;
    pbw_status status;
    memset(&tree, 0, sizeof(tree));
    queries->tree = &tree;
    status = pbwq__tree_build(queries, &tree);
    status = status != PBW_OK ? status
           : pbwq__answer_all(queries, pbwq__search_block, queries->input.count, PBWQ__BLOCK_QUERIES);
    pbw__release(memory, tree.vertex, mesh->point_count, sizeof(pbw_index));
    pbw__release(memory, tree.coordinate, tree.nodes[0] * width, sizeof(double));
    pbw__release(memory, tree.box, tree.groups * 2 * width, sizeof(double));
    return status;
}
#endif

static pbw_status pbwq__nearest_all(pbwq__queries *queries, const pbw_lists *stars)
{
    pbw_status status;
    pbwq__find_unit(queries);
#ifdef PBW__SIMD
    /* The tree knows no weights and at most PBWQ__NEAR_LIST neighbours.  With the caller's stars the mesh is faster
       for few queries, and for one neighbour: in 0.5 to 0.7 of the time of the tree.  On lattices it takes 1.2 to 2.5
       times as long, but in the plane and along the curve 0.8. */
    const int tied = queries->large > 0.0 && (queries->mesh->dim == 3 || queries->mesh->original == NULL);
    if (pbw__simd_works() && queries->mesh->weights == NULL && queries->k <= PBWQ__NEAR_LIST
        && queries->mesh->point_count > 0
        && (stars == NULL || ((queries->k > 1 || tied)
                              && queries->input.count >= queries->mesh->point_count / 8))) {
        return pbwq__search_all(queries);
    }
#endif
    status = pbwq__take_stars(queries, stars);
    status = status != PBW_OK ? status
           : pbwq__answer_all(queries, pbwq__nearest_block, queries->input.count,
                            queries->k == 1 ? pbwq__walk_block(queries->input.count) : pbwq__near_block(queries->k));
    return status;
}

PBWDEF pbw_status pbw_nearest(const pbw_mesh *mesh, const pbw_lists *stars, const double *points, size_t count,
                              size_t k, const pbw_options *options, pbw_index *vertices, double *distances)
{
    pbwq__queries queries;
    pbw_status status;
    if ((vertices == NULL && count != 0 && k != 0) || !pbwq__fits(mesh, stars)) {
        return PBW_ERROR_ARGUMENT;
    }
    if (count != 0 && k > (size_t)-1 / sizeof(double) / count) {
        return PBW_ERROR_TOO_LARGE;
    }
    status = pbwq__queries_start(&queries, mesh, points, count, options);
    if (status == PBW_OK && count != 0 && k != 0) {
        queries.k = k;
        queries.vertices = vertices;
        queries.distances = distances;
        status = pbwq__nearest_all(&queries, stars);
    }
    return pbwq__queries_end(&queries, status);
}
/* ------------------------------------------------------------------------------------------------------
   >>centres      Vectors of doubles or of pairs of doubles; centres of simplices in both.
   In: points, weights.  Out: centres, relative to a point; orientations to nearly the full precision of doubles.
   Holds: with `fine`, and but for underflow, the error of the determinant and of each numerator of a centre is at
   most 2^-98 times the sum of the absolute products, of coordinates relative to the query.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwq__vector { pbw_pair x, y, z; } pbwq__vector;

/* ---- arithmetic: on pairs if `fine`, otherwise on their heads only */
PBW__INLINE pbw_pair pbwq__number(double head)
{
    pbw_pair number;
    number.head = head;
    number.tail = 0.0;
    return number;
}

PBW__INLINE pbw_pair pbwq__add(int fine, pbw_pair a, pbw_pair b)
{
    return fine ? pbw__pair_plus(a, b) : pbwq__number(a.head + b.head);
}

PBW__INLINE pbw_pair pbwq__sub(int fine, pbw_pair a, pbw_pair b)
{
    return fine ? pbw__pair_minus(a, b) : pbwq__number(a.head - b.head);
}

PBW__INLINE pbw_pair pbwq__mul(int fine, pbw_pair a, pbw_pair b)
{
    return fine ? pbw__pair_times(a, b) : pbwq__number(a.head * b.head);
}

/* Divides.  b is normalised first, |tail| <= u |head|, so that one correction by the remainder is enough. */
PBW__INLINE pbw_pair pbwq__div(int fine, pbw_pair a, pbw_pair b)
{
    pbw_pair quotient, rest;
    double head = b.head + b.tail;
    if (!fine) {
        return pbwq__number(a.head / b.head);
    }
    b.tail = (b.head - head) + b.tail;
    b.head = head;
    quotient = pbwq__number((a.head + a.tail) / head);
    rest = pbw__pair_minus(a, pbw__pair_times(quotient, b));
    quotient.tail = (rest.head + rest.tail) / head;
    return quotient;
}

PBW__INLINE pbwq__vector pbwq__vector_sub(int fine, pbwq__vector a, pbwq__vector b)
{
    a.x = pbwq__sub(fine, a.x, b.x);
    a.y = pbwq__sub(fine, a.y, b.y);
    a.z = pbwq__sub(fine, a.z, b.z);
    return a;
}

PBW__INLINE pbwq__vector pbwq__vector_add(int fine, pbwq__vector a, pbwq__vector b)
{
    a.x = pbwq__add(fine, a.x, b.x);
    a.y = pbwq__add(fine, a.y, b.y);
    a.z = pbwq__add(fine, a.z, b.z);
    return a;
}

PBW__INLINE pbwq__vector pbwq__vector_times(int fine, pbwq__vector a, pbw_pair factor)
{
    a.x = pbwq__mul(fine, a.x, factor);
    a.y = pbwq__mul(fine, a.y, factor);
    a.z = pbwq__mul(fine, a.z, factor);
    return a;
}

PBW__INLINE pbw_pair pbwq__vector_dot(int fine, pbwq__vector a, pbwq__vector b)
{
    return pbwq__add(fine, pbwq__add(fine, pbwq__mul(fine, a.x, b.x), pbwq__mul(fine, a.y, b.y)),
                     pbwq__mul(fine, a.z, b.z));
}

/* a x b in the plane, and in space. */
PBW__INLINE pbw_pair pbwq__vector_area(int fine, pbwq__vector a, pbwq__vector b)
{
    return pbwq__sub(fine, pbwq__mul(fine, a.x, b.y), pbwq__mul(fine, a.y, b.x));
}

PBW__INLINE pbwq__vector pbwq__vector_cross(int fine, pbwq__vector a, pbwq__vector b)
{
    pbwq__vector c;
    c.x = pbwq__sub(fine, pbwq__mul(fine, a.y, b.z), pbwq__mul(fine, a.z, b.y));
    c.y = pbwq__sub(fine, pbwq__mul(fine, a.z, b.x), pbwq__mul(fine, a.x, b.z));
    c.z = pbwq__sub(fine, pbwq__mul(fine, a.x, b.y), pbwq__mul(fine, a.y, b.x));
    return c;
}

/* ---- exact numbers */
/* c = a x b */
static void pbwq__exact_cross(const pbw__integer *a, const pbw__integer *b, pbw__integer *c, pbw__digit **top)
{
    pbw__product term[2];
    int k;
    for (k = 0; k < 3; k++) {
        term[0].factor[0] = a + (k + 1) % 3;
        term[0].factor[1] = b + (k + 2) % 3;
        term[0].negative = 0;
        term[1].factor[0] = a + (k + 2) % 3;
        term[1].factor[1] = b + (k + 1) % 3;
        term[1].negative = 1;
        c[k] = pbw__exact_sum(term, 2, top);
    }
}

/* Returns the sum of a[i] b[i * step]. */
static pbw__integer pbwq__exact_dot(const pbw__integer *a, const pbw__integer *b, int step, int count,
                                    pbw__digit **top)
{
    pbw__product term[4];
    int i;
    for (i = 0; i < count; i++) {
        term[i].factor[0] = a + i;
        term[i].factor[1] = b + i * step;
        term[i].negative = 0;
    }
    return pbw__exact_sum(term, count, top);
}

static pbw__integer pbwq__exact_number(int value, pbw__digit **top)
{
    pbw__integer number = { NULL, 0, 0 };
    number.digit = (*top)++;
    number.digit[0] = value;
    number.length = value != 0;
    return number;
}

/* Stores p - origin.  In the plane z is 0.  If p is NULL the row is (0, 0, 1), which turns determinants of space into
   those of the plane. */
static void pbwq__exact_row(int dim, const double *p, const double *origin, int unit, pbw__integer *row,
                            pbw__digit **top)
{
    int k;
    for (k = 0; k < 3; k++) {
        row[k] = k < dim && p != NULL ? pbw__exact_difference(p[k], origin[k], unit, top)
                                      : pbwq__exact_number(p == NULL && k == 2, top);
    }
}

/* Returns a / radix^length as a pair; digits far below 2^-106 are dropped. */
static pbw_pair pbwq__exact_pair(const pbw__integer *a, int length)
{
    const double radix = 1.0 / (double)((pbw__column)1 << PBW__DIGIT_BITS);
    const pbw__digit half = (pbw__digit)1 << (PBW__DIGIT_BITS / 2);
    pbw_pair sum = { 0.0, 0.0 }, piece = { 0.0, 0.0 };
    double weight = radix;
    int i;
    for (i = length - 1; i >= 0 && i >= length - 10; i--, weight *= radix) {
        if (i < a->length) {                         /* two pieces, each exact in a double */
            piece.head = (double)(a->digit[i] / half * half) * weight;
            sum = pbw__pair_plus(sum, piece);
            piece.head = (double)(a->digit[i] % half) * weight;
            sum = pbw__pair_plus(sum, piece);
        }
    }
    return sum;
}

/* ---- orientations */
/* Computes the orientations of pbwq__sides3 and pbwq__sides2 from exact integers, all times one common factor. */
static PBW__NOINLINE void pbwq__exact_sides(const pbw_mesh *mesh, const pbw_index *v, const double *p, double *side)
{
    const int dim = mesh->dim;
    pbw__digit pool[PBW__POOL], *top = pool;
    pbw__integer row[4][3], normal[3], value[4];
    const double *x[4] = { NULL, NULL, NULL, NULL };
    int unit = pbw__exact_unit(p, dim, 1024), longest = 0, i;
    for (i = 0; i <= dim; i++) {
        x[i] = mesh->points + v[i] * (size_t)dim;
        unit = pbw__exact_unit(x[i], dim, unit);
    }
    for (i = 0; i < 4; i++) {
        pbwq__exact_row(dim, x[i], p, unit, row[i], &top);
    }
    for (i = 0; i <= dim; i++) {                     /* the rows other than i, in cyclic order */
        pbwq__exact_cross(row[(i + 2) % 4], row[(i + 3) % 4], normal, &top);
        value[i] = pbwq__exact_dot(row[(i + 1) % 4], normal, 1, 3, &top);
        longest = value[i].length > longest ? value[i].length : longest;
    }
    for (i = 0; i <= dim; i++) {
        const pbw_pair pair = pbwq__exact_pair(value + i, longest);
        side[i] = i % 2 == 0 ? pair.head + pair.tail : -(pair.head + pair.tail);     /* a cycle of 4 rows is odd */
    }
}

/* Returns the centre c of a simplex, relative to the origin of its rows: 2 c . row = lift for each row.  Rows are at
   most 2 long.  Sets *flat if their determinant is too small for an accurate centre. */
PBW__INLINE pbwq__vector pbwq__centre_of(int fine, int dim, const pbwq__vector *row, const pbw_pair *lift, int *flat)
{
    pbwq__vector sum;
    pbw_pair det;
    if (dim == 3) {
        const pbwq__vector yz = pbwq__vector_cross(fine, row[1], row[2]);
        sum = pbwq__vector_times(fine, yz, lift[0]);
        sum = pbwq__vector_add(fine, sum,
                               pbwq__vector_times(fine, pbwq__vector_cross(fine, row[2], row[0]), lift[1]));
        sum = pbwq__vector_add(fine, sum,
                               pbwq__vector_times(fine, pbwq__vector_cross(fine, row[0], row[1]), lift[2]));
        det = pbwq__vector_dot(fine, row[0], yz);
    } else {
        sum.x = pbwq__sub(fine, pbwq__mul(fine, lift[0], row[1].y), pbwq__mul(fine, lift[1], row[0].y));
        sum.y = pbwq__sub(fine, pbwq__mul(fine, lift[1], row[0].x), pbwq__mul(fine, lift[0], row[1].x));
        sum.z = pbwq__number(0.0);
        det = pbwq__vector_area(fine, row[0], row[1]);
    }
    *flat = !(pbw__abs(det.head) > (fine ? 1e-6 : 1e-9));
    return pbwq__vector_times(fine, sum, pbwq__div(fine, pbwq__number(0.5), det));
}

/* The centre of a simplex, relative to q, in units of 2^(unit-1): at / by. */
typedef struct pbwq__exact_point { pbw__integer at[3], by; } pbwq__exact_point;

/* Returns a / (by[0] by[1] ..) * 2^exponent. */
static pbw_pair pbwq__exact_quotient(const pbw__integer *a, const pbw__integer *const *by, int count, int exponent)
{
    pbw_pair value = pbwq__exact_pair(a, a->length);
    double some, rest;
    int i;
    exponent += PBW__DIGIT_BITS * a->length;
    for (i = 0; i < count; i++) {
        value = pbwq__div(1, value, pbwq__exact_pair(by[i], by[i]->length));
        exponent -= PBW__DIGIT_BITS * by[i]->length;
    }
    some = pbw__power_of_two(exponent / 2);
    rest = pbw__power_of_two(exponent - exponent / 2);
    return pbw__pair_scaled(pbw__pair_scaled(value, some), rest);
}
/* ------------------------------------------------------------------------------------------------------
   >>interpolate  Weights of vertices for a point inside: barycentric, Sibson's, Laplace's.
   In: the simplex that contains a query q.  Out: vertices and weights that have q as their mean.

   Sibson's weights (1981) are the volumes that the cell of q would take from the cells of its neighbours.  The mesh
   is not changed: the simplices in conflict with q form a cavity; q and its boundary facets would be the new ones.
   Each facet abc between two simplices is dual to an edge from the centre n behind it to the centre s in front, from
   where a, b, c are counter-clockwise.  Relative to any one origin, this dual edge adds a volume to the cells of a
   and of b for the edge ab; six times this volume is

       ((b - a) . (n x s) - (n - s) . (a x b)) / 2 * (1 +- (w_a - w_b) / |b - a|^2)

   The sum over all facets is the volume of each cell, even if centres lie outside of their simplices.  So q takes
   from each cell the sum over the facets inside the cavity, plus the sum over the boundary facets, from the new
   centre to the old centre inside, minus the sum over the facets at q.  (The old centre outside lies on the line
   through those two and cancels, so a hull facet is no special case.)  In the plane an edge ab adds
   (n - a) x (s - a) for a and (s - b) x (n - b) for b, twice the area.
   Laplace's weight of a neighbour is the area (in the plane, the length) of the facet between its cell and that of q,
   divided by its distance from q.  The facets at q yield these areas.

   Coordinates are relative to q and scaled by a power of two.  Centres of nearly flat simplices are far away and
   badly conditioned.  If there are any, or if the weighted mean of the neighbours is not q, the weights are computed
   again with pairs of doubles, and with exact integers for the centres of flat simplices.  Where centres are so far
   that rounding errors of their products may matter beside the sum, doubles give way to pairs, and pairs to exact
   integers for each contribution.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwq__site { pbwq__vector at; pbw_pair weight, gain; pbw_index vertex; } pbwq__site;

/* A simplex of the cavity: the sites at its corners; across from each, a simplex of the cavity or PBW_NONE.  Or a new
   simplex, of a facet of the boundary and q: q is PBW_NONE, the last corner, and across[0] the old simplex inside. */
typedef struct pbwq__cell { pbwq__vector centre; pbw_index simplex, corner[4], across[4]; } pbwq__cell;

/* The cavity of a query. */
struct pbwq__cavity {
    const pbw_mesh *mesh;
    pbwq__site *site;
    pbwq__cell *old, *face;                           /* face: the new ones */
    size_t old_capacity, site_capacity, face_capacity;
    size_t simplices, sites, faces;
    double query[3];
    int scale;                                       /* sites are 2^scale times as far from q */
    int unit;                                        /* of exact numbers */
};

static void pbwq__cavity_free(pbw_memory *memory, pbwq__cavity *cavity)
{
    if (cavity != NULL) {
        PBW__RELEASE(memory, cavity, old);
        PBW__RELEASE(memory, cavity, site);
        PBW__RELEASE(memory, cavity, face);
        pbw__release(memory, cavity, 1, sizeof(pbwq__cavity));
    }
}

/* Adds the barycentric coordinates of p in the simplex that contains it; leaves out zeros. */
static void pbwq__barycentric(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t query,
                              const pbwq__location *location, const double *p)
{
    const pbw_mesh *mesh = queries->mesh;
    const size_t corners = (size_t)mesh->dim + 1;
    const pbw_index *v = mesh->simplices + location->simplex * corners;
    pbw_index *items;
    double side[4], *values, total = 0.0, bound;
    size_t i, at, count = 0;
    bound = mesh->dim == 3 ? pbwq__sides3(mesh->points, v, p, side) : pbwq__sides2(mesh->points, v, p, side);
    for (i = 0; i < corners; i++) {
        total += side[i];
    }
    if (!(bound < 1e-14 * total)) {
        pbwq__exact_sides(mesh, v, p, side);
    }
    for (total = 0.0, i = 0; i < corners; i++) {
        side[i] = (location->on >> i & 1) == 0 && side[i] > 0.0 ? side[i] : 0.0;
        total += side[i];
        count += side[i] > 0.0;
    }
    items = pbwq__chunk_add(queries, scratch, block, query, count, &values);
    if (items != NULL) {
        for (at = i = 0; i < corners; i++) {
            if (side[i] > 0.0) {
                items[at] = v[i];
                values[at++] = side[i] / total;
            }
        }
        pbwq__sort_items(items, values, count);
    }
}

/* ---- the cavity */
/* Returns whether p, a record, is in conflict with simplex t: by the tie rule if `tied`, else strictly. */
PBW__INLINE int pbwq__has_conflict(const pbwq__queries *queries, int dim, size_t t, const double *p, int tied)
{
    const pbw_mesh *mesh = queries->mesh;
    const pbw_index *v = mesh->simplices + t * (size_t)(dim + 1);
    double record[4][4];
    const double *x[4];
    int i;
    for (i = 0; i <= dim; i++) {
        memcpy(record[i], mesh->points + v[i] * (size_t)dim, (size_t)dim * sizeof(double));
        record[i][dim] = mesh->weights != NULL ? mesh->weights[v[i]] : 0.0;
        x[i] = record[i];
    }
    return tied ? pbw__conflict(dim, x, p, &queries->grid) : pbw__power(dim, x, p, &queries->grid) > 0;
}

static int pbwq__cavity_reserve(pbwq__scratch *scratch, pbwq__cavity *cavity)
{
    return pbwq__room(scratch, &cavity->old, &cavity->old_capacity, cavity->simplices + 4, sizeof(pbwq__cell))
        && pbwq__room(scratch, &cavity->site, &cavity->site_capacity, cavity->sites + 4, sizeof(pbwq__site))
        && pbwq__room(scratch, &cavity->face, &cavity->face_capacity, cavity->faces + 4, sizeof(pbwq__cell));
}

/* The corners of the facet opposite to each corner, counter-clockwise seen from that corner. */
static const unsigned char pbwq__opposite[2][4][3] = {
    { { 1, 2, 0 }, { 2, 0, 0 }, { 0, 1, 0 }, { 0, 0, 0 } }, { { 1, 3, 2 }, { 0, 2, 3 }, { 1, 0, 3 }, { 0, 1, 2 } }
};

/* Adds to the boundary the facet opposite to corner i of the cavity's simplex s. */
PBW__INLINE void pbwq__cavity_face(pbwq__cavity *cavity, int dim, size_t s, size_t i)
{
    pbwq__cell *face = cavity->face + cavity->faces++;
    int k;
    for (k = 0; k < 3; k++) {
        face->corner[k] = cavity->old[s].corner[pbwq__opposite[dim - 2][i][k]];
    }
    face->corner[dim] = PBW_NONE;
    face->across[0] = (pbw_index)s;
}

/* Finds the simplices in conflict with q by a flood from t, which is one of them.  Their corners become the sites;
   the facets to simplices without conflict become the boundary.  Returns 0 if memory is short. */
PBW__INLINE int pbwq__cavity_find(const pbwq__queries *queries, int dim, pbwq__scratch *scratch, size_t t,
                                  const double *q)
{
    const pbw_mesh *mesh = queries->mesh;
    const size_t corners = (size_t)dim + 1;
    pbwq__cavity *cavity = scratch->cavity;
    size_t next, i;
    int added;
    cavity->simplices = 1;
    cavity->sites = cavity->faces = 0;
    if (!pbwq__set_clear(scratch, &scratch->seen) || !pbwq__set_clear(scratch, &scratch->other)
        || !pbwq__cavity_reserve(scratch, cavity) || pbwq__set_add(scratch, &scratch->seen, t, 0, &added) == NULL) {
        return 0;
    }
    cavity->old[0].simplex = (pbw_index)t;
    for (next = 0; next < cavity->simplices; next++) {
        const size_t s = cavity->old[next].simplex;
        pbwq__cell *old;
        if (!pbwq__cavity_reserve(scratch, cavity)) {
            return 0;
        }
        old = cavity->old + next;
        for (i = 0; i < corners; i++) {
            const pbw_index vertex = mesh->simplices[s * corners + i];
            const uint32_t *site = pbwq__set_add(scratch, &scratch->other, vertex, (uint32_t)cavity->sites, &added);
            if (site == NULL) {
                return 0;
            }
            old->corner[i] = *site;
            if (added) {
                cavity->site[cavity->sites++].vertex = vertex;
            }
        }
        for (i = 0; i < corners; i++) {
            const pbw_index other = mesh->neighbors[s * corners + i];
            uint32_t *known = NULL;
            old->across[i] = PBW_NONE;
            if (other != PBW_NONE) {
                known = pbwq__set_add(scratch, &scratch->seen, other, PBW_NONE, &added);
                if (known == NULL) {
                    return 0;
                }
                if (added && pbwq__has_conflict(queries, dim, other, q, 1)) {
                    *known = (uint32_t)cavity->simplices;
                    cavity->old[cavity->simplices++].simplex = other;
                }
                old->across[i] = *known;
            }
            if (old->across[i] == PBW_NONE) {
                pbwq__cavity_face(cavity, dim, next, i);
            }
        }
    }
    return 1;
}

/* Makes the sites relative to q, scaled by a power of two so that the farthest is about 1 away. */
PBW__INLINE void pbwq__cavity_relative(const pbw_mesh *mesh, int dim, pbwq__cavity *cavity, const double *q)
{
    double largest = 0.0, scale;
    size_t i;
    int k;
    cavity->mesh = mesh;
    memcpy(cavity->query, q, (size_t)dim * sizeof(q[0]));
    for (i = 0; i < cavity->sites; i++) {
        for (k = 0; k < dim; k++) {
            largest = pbw__max(largest,
                                  pbw__abs(mesh->points[cavity->site[i].vertex * (size_t)dim + (size_t)k] - q[k]));
        }
    }
    cavity->scale = largest < 1e300 ? -pbw__exponent(largest) : -1000;
    scale = pbw__power_of_two(cavity->scale);
    for (i = 0; i < cavity->sites; i++) {
        pbwq__site *site = cavity->site + i;
        const double *p = mesh->points + site->vertex * (size_t)dim;
        pbw_pair *at[3];
        at[0] = &site->at.x;
        at[1] = &site->at.y;
        at[2] = &site->at.z;
        site->at.z = pbwq__number(0.0);
        for (k = 0; k < dim; k++) {
            *at[k] = pbw__pair_scaled(pbw__pair_difference(p[k], q[k]), scale);
        }
        site->weight = pbwq__number(mesh->weights != NULL ? mesh->weights[site->vertex] * scale * scale : 0.0);
    }
}

/* Stores the centre of a simplex. */
static void pbwq__exact_centre(const pbwq__cavity *cavity, const pbwq__cell *x, pbwq__exact_point *centre,
                               pbw__digit **top)
{
    const pbw_mesh *mesh = cavity->mesh;
    const int dim = mesh->dim, unit = cavity->unit;
    const double *q = cavity->query, *point[4], *origin;
    pbw__integer row[3][4], same[4], lift[3], normal[3][3], twice[3];
    pbw__product term[4];
    double weight[4];
    int i, k;
    for (i = 0; i <= dim; i++) {
        const size_t v = x->corner[i] != PBW_NONE ? cavity->site[x->corner[i]].vertex : 0;
        point[i] = x->corner[i] != PBW_NONE ? mesh->points + v * (size_t)dim : q;
        weight[i] = mesh->weights != NULL && x->corner[i] != PBW_NONE ? mesh->weights[v] : 0.0;
    }
    origin = point[dim];
    for (i = 0; i < 3; i++) {
        pbwq__exact_row(dim, i < dim ? point[i] : NULL, origin, unit, row[i], top);
        memcpy(same, row[i], sizeof(row[i]));
        lift[i] = pbwq__exact_number(0, top);
        same[3] = pbwq__exact_number(-1, top);
        if (i < dim) {                               /* |row|^2 - dw */
            row[i][3] = pbw__exact_difference(weight[i], weight[dim], 2 * unit, top);
            lift[i] = pbwq__exact_dot(row[i], same, 1, 4, top);
        }
        twice[i] = pbw__exact_difference(i < dim ? origin[i] : 0.0, i < dim ? q[i] : 0.0, unit - 1, top);
    }
    for (i = 0; i < 3; i++) {                        /* the cofactors of lift i */
        pbwq__exact_cross(row[(i + 1) % 3], row[(i + 2) % 3], normal[i], top);
    }
    centre->by = pbwq__exact_dot(row[0], normal[0], 1, 3, top);
    for (k = 0; k < 3; k++) {
        for (i = 0; i < 4; i++) {
            term[i].factor[0] = i < 3 ? lift + i : &centre->by;
            term[i].factor[1] = i < 3 ? &normal[i][k] : twice + k;
            term[i].negative = 0;
        }
        centre->at[k] = pbw__exact_sum(term, 4, top);
    }
}

/* Returns the centre in pairs; only the quotients are rounded. */
static PBW__NOINLINE pbwq__vector pbwq__cavity_flat_centre(const pbwq__cavity *cavity, const pbwq__cell *x)
{
    const int exponent = cavity->unit - 1 + cavity->scale;
    pbw__digit pool[2 * PBW__POOL], *top = pool;
    pbwq__exact_point centre;
    const pbw__integer *by = &centre.by;
    pbwq__vector result;
    pbwq__exact_centre(cavity, x, &centre, &top);
    result.x = pbwq__exact_quotient(centre.at, &by, 1, exponent);
    result.y = pbwq__exact_quotient(centre.at + 1, &by, 1, exponent);
    result.z = pbwq__exact_quotient(centre.at + 2, &by, 1, exponent);
    return result;
}

/* Computes the centre of a simplex.  Returns 0 if it is too flat for doubles; with `fine` it is right even so. */
PBW__INLINE int pbwq__cavity_centre(int fine, int dim, int weighted, const pbwq__cavity *cavity, pbwq__cell *x)
{
    const pbwq__site *base = x->corner[dim] != PBW_NONE ? cavity->site + x->corner[dim] : NULL;
    pbwq__vector row[3];
    pbw_pair lift[3];
    int flat, k;
    for (k = 0; k < dim; k++) {
        const pbwq__site *site = cavity->site + x->corner[k];
        pbw_pair weight = site->weight;
        row[k] = site->at;
        if (base != NULL) {
            row[k] = pbwq__vector_sub(fine, site->at, base->at);
            weight = pbwq__sub(fine, weight, base->weight);
        }
        lift[k] = pbwq__vector_dot(fine, row[k], row[k]);
        if (weighted) {
            lift[k] = pbwq__sub(fine, lift[k], weight);
        }
    }
    x->centre = pbwq__centre_of(fine, dim, row, lift, &flat);
    if (base != NULL) {
        x->centre = pbwq__vector_add(fine, base->at, x->centre);
    }
    if (fine && flat) {
        x->centre = pbwq__cavity_flat_centre(cavity, x);
    }
    return !flat;
}

/* Adds to the gains, by exact integers, the contributions of the dual edge from n to s to the polygons dual to the
   edges of its facet: the volume of the cone from q over the triangle of the edge and a corner of the polygon, the
   first centre met.  In the plane, that of q and the dual edge.  Laplace's weight is that of the polygons dual to
   edges at q, divided by its height, which is the lift of the other end.  Each is rounded once. */
static PBW__NOINLINE void pbwq__cavity_exact(int laplace, pbwq__scratch *scratch, pbwq__site *const *x,
                                             const pbwq__cell *const *ends)
{
    const pbwq__cell *n = ends[0];
    const pbwq__cavity *cavity = scratch->cavity;
    const int dim = cavity->mesh->dim, exponent = dim * (cavity->unit - 1 + cavity->scale);
    const size_t id = n->corner[dim] == PBW_NONE ? cavity->simplices + (size_t)(n - cavity->face)
                                                 : (size_t)(n - cavity->old);
    pbw__digit pool[5 * PBW__POOL], *top = pool, *bottom;
    pbwq__exact_point first, from, to;
    pbw__integer normal[3], volume, row[4], same[4];
    const pbw__integer *by[4] = { &from.by, &to.by, &first.by, &volume };
    int i, k, added;
    pbwq__exact_centre(cavity, n, &from, &top);
    pbwq__exact_centre(cavity, ends[1], &to, &top);
    pbwq__exact_cross(from.at, to.at, normal, &top);
    for (i = laplace && dim == 3, bottom = top; i < (dim == 3 ? 3 : 1); i++, top = bottom) {
        pbwq__site *a = x[i], *b = x[i < 2 ? i + 1 : 0], *end = a->vertex != PBW_NONE ? a : b;
        const uint64_t low = a->vertex < b->vertex ? a->vertex : b->vertex, high = a->vertex ^ b->vertex ^ low;
        pbw__integer det;
        pbw_pair value;
        if (dim == 3) {
            const uint32_t *met = pbwq__set_add(scratch, &scratch->other, low << 32 | high, (uint32_t)id, &added);
            if (met == NULL) {
                return;
            }
            pbwq__exact_centre(cavity, *met < cavity->simplices ? cavity->old + *met
                                     : cavity->face + (*met - cavity->simplices), &first, &top);
        } else {
            for (k = 0; k < 3; k++) {
                first.at[k] = pbwq__exact_number(k == 2, &top);
            }
            first.by = first.at[2];
        }
        det = pbwq__exact_dot(first.at, normal, 1, 3, &top);
        if (laplace) {
            pbwq__exact_row(dim, cavity->mesh->points + end->vertex * (size_t)dim, cavity->query, cavity->unit, row,
                            &top);
            memcpy(same, row, sizeof(row));
            row[3] = pbw__exact_difference(cavity->mesh->weights != NULL ? cavity->mesh->weights[end->vertex] : 0.0,
                                           0.0, 2 * cavity->unit, &top);
            same[3] = pbwq__exact_number(-1, &top);
            volume = pbwq__exact_dot(row, same, 1, 4, &top);
        }
        if (det.length > 0) {
            value = pbwq__exact_quotient(&det, by, laplace ? 4 : 3,
                                         laplace ? exponent - 2 * (cavity->unit + cavity->scale) : exponent);
            a->gain = pbw__pair_plus(a->gain, value);
            b->gain = pbw__pair_minus(b->gain, value);
        }
    }
}

/* Adds to the gains of a and b the contribution of the dual edge from n to s for the edge ab:
   (b - a) . cross - away . (a x b), where cross = n x s and away = n - s. */
PBW__INLINE void pbwq__cavity_edge(int fine, int weighted, pbwq__site *a, pbwq__site *b, pbwq__vector cross,
                                   pbwq__vector away)
{
    const pbwq__vector along = pbwq__vector_sub(fine, b->at, a->at);
    pbw_pair value = pbwq__sub(fine, pbwq__vector_dot(fine, along, cross),
                               pbwq__vector_dot(fine, away, pbwq__vector_cross(fine, a->at, b->at)));
    if (weighted) {
        pbw_pair more = pbwq__div(fine, pbwq__mul(fine, value, pbwq__sub(fine, a->weight, b->weight)),
                                  pbwq__vector_dot(fine, along, along));
        b->gain = pbwq__sub(fine, b->gain, more);
        a->gain = pbwq__add(fine, a->gain, more);
    }
    a->gain = pbwq__add(fine, a->gain, value);
    b->gain = pbwq__add(fine, b->gain, value);
}

/* Adds the contributions of the dual edge from n to s for all edges of its facet, counter-clockwise seen from s. */
PBW__INLINE void pbwq__cavity_facet(int fine, int dim, int weighted, pbwq__scratch *scratch, pbwq__site *const *x,
                                    const pbwq__cell *const *ends)
{
    const pbwq__vector n = ends[0]->centre, s = ends[1]->centre;
    if (fine > 1) {
        pbwq__cavity_exact(0, scratch, x, ends);
    } else if (dim == 3) {
        const pbwq__vector cross = pbwq__vector_cross(fine, n, s), away = pbwq__vector_sub(fine, n, s);
        pbwq__cavity_edge(fine, weighted, x[0], x[1], cross, away);
        pbwq__cavity_edge(fine, weighted, x[1], x[2], cross, away);
        pbwq__cavity_edge(fine, weighted, x[2], x[0], cross, away);
    } else {
        pbwq__site *a = x[0], *b = x[1];
        a->gain = pbwq__add(fine, a->gain, pbwq__vector_area(fine, pbwq__vector_sub(fine, n, a->at),
                                                             pbwq__vector_sub(fine, s, a->at)));
        b->gain = pbwq__add(fine, b->gain, pbwq__vector_area(fine, pbwq__vector_sub(fine, s, b->at),
                                                             pbwq__vector_sub(fine, n, b->at)));
    }
}

/* Subtracts from the gains the contribution of the dual edge of a new facet: the facet of q and x[0], in space also
   x[1], counter-clockwise seen from s, between the new simplices with centres n and s.  scheme: 1 with weights; 2 for
   Laplace's weights: adds the contribution to the facet between the cells of q and x[0], and in space of q and x[1],
   each divided by the distance of the two. */
PBW__INLINE void pbwq__cavity_spoke(int fine, int dim, int scheme, pbwq__scratch *scratch, pbwq__site *const *x,
                                    const pbwq__cell *const *ends)
{
    const pbwq__cell *const back[2] = { ends[1], ends[0] };
    pbwq__site origin, *corner[3];
    memset(&origin, 0, sizeof(origin));
    origin.vertex = PBW_NONE;
    corner[0] = x[0];
    corner[1] = dim == 3 ? x[1] : &origin;
    corner[2] = &origin;
    if (scheme < 2) {
        pbwq__cavity_facet(fine, dim, scheme, scratch, corner, back);
    } else if (fine > 1) {
        pbwq__cavity_exact(1, scratch, corner, back);
    } else {
        const pbwq__vector cross = dim == 3 ? pbwq__vector_cross(fine, ends[0]->centre, ends[1]->centre)
                                           : pbwq__vector_sub(fine, ends[0]->centre, ends[1]->centre);
        x[0]->gain = pbwq__add(fine, x[0]->gain,
                               pbwq__div(fine, dim == 3 ? pbwq__vector_dot(fine, x[0]->at, cross)
                                                      : pbwq__vector_area(fine, x[0]->at, cross),
                                         pbwq__vector_dot(fine, x[0]->at, x[0]->at)));
        if (dim == 3) {
            x[1]->gain = pbwq__sub(fine, x[1]->gain, pbwq__div(fine, pbwq__vector_dot(fine, x[1]->at, cross),
                                                               pbwq__vector_dot(fine, x[1]->at, x[1]->at)));
        }
    }
}

/* Adds the contributions of all facets at q.  Each belongs to a ridge (in the plane, a vertex) where two boundary
   facets meet.  Returns 0 if memory is short. */
PBW__INLINE int pbwq__cavity_spokes(int fine, int dim, int weighted, int laplace, pbwq__scratch *scratch)
{
    pbwq__cavity *cavity = scratch->cavity;
    size_t f;
    int k, added;
    if (!pbwq__set_clear(scratch, &scratch->seen)) {
        return 0;
    }
    for (f = 0; f < cavity->faces; f++) {
        const pbwq__cell *face = cavity->face + f;
        for (k = 0; k < dim; k++) {
            const pbw_index a = face->corner[k], b = dim == 3 ? face->corner[k < 2 ? k + 1 : 0] : a;
            const uint64_t key = a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
            const uint32_t *other = pbwq__set_add(scratch, &scratch->seen, key, (uint32_t)f, &added);
            if (other == NULL) {
                return 0;
            }
            if (!added) {
                const pbwq__cell *first = cavity->face + *other;
                const int turn = dim == 2 && k == 0; /* this edge begins at a: counter-clockwise for the other */
                const pbwq__cell *const ends[2] = { turn ? face : first, turn ? first : face };
                pbwq__site *const x[2] = { cavity->site + b, cavity->site + a };
                pbwq__cavity_spoke(fine, dim, laplace ? 2 : weighted, scratch, x, ends);
            }
        }
    }
    return 1;
}

/* Computes the gain of each site, with fine = 2 by exact integers.  Returns 1 if the weights that they give are
   right, otherwise 0; -1 if memory is short. */
PBW__INLINE int pbwq__cavity_weigh(int fine, int weighted, int laplace, pbwq__scratch *scratch, int dim)
{
    pbwq__cavity *cavity = scratch->cavity;
    const pbwq__cell *ends[2];
    pbwq__site *x[3];
    double mean[3] = { 0.0, 0.0, 0.0 }, total = 0.0, size = 1.0, off;
    size_t i, s;
    int k, round = 1;
    for (i = 0; i < cavity->simplices + cavity->faces && fine < 2; i++) {
        pbwq__cell *cell = i < cavity->faces ? cavity->face + i : cavity->old + (i - cavity->faces);
        if (i < cavity->faces || !laplace) {
            round &= pbwq__cavity_centre(fine, dim, weighted, cavity, cell);
            size = pbw__max(size, pbw__max_abs(cell->centre.x.head, cell->centre.y.head, cell->centre.z.head, 0.0));
        }
    }
    if (!fine && !round) {
        return 0;
    }
    for (i = 0; i < cavity->sites; i++) {
        cavity->site[i].gain = pbwq__number(0.0);
    }
    for (s = 0; s < cavity->simplices && !laplace; s++) {
        for (i = 0; i <= (size_t)dim; i++) {
            const pbw_index n = cavity->old[s].across[i];
            if (n < s) {                             /* a facet inside, once */
                for (k = 0; k < dim; k++) {
                    x[k] = cavity->site + cavity->old[s].corner[pbwq__opposite[dim - 2][i][k]];
                }
                ends[0] = cavity->old + n;
                ends[1] = cavity->old + s;
                pbwq__cavity_facet(fine, dim, weighted, scratch, x, ends);
            }
        }
    }
    for (i = 0; i < cavity->faces && !laplace; i++) {
        const pbwq__cell *face = cavity->face + i;
        for (k = 0; k < dim; k++) {
            x[k] = cavity->site + face->corner[k];
        }
        ends[0] = face;
        ends[1] = cavity->old + face->across[0];
        pbwq__cavity_facet(fine, dim, weighted, scratch, x, ends);
    }
    if (!pbwq__cavity_spokes(fine, dim, weighted, laplace, scratch) || scratch->failed) {
        return -1;
    }
    for (i = 0; i < cavity->sites; i++) {
        const pbwq__site *site = cavity->site + i;
        const double gain = pbw__max(site->gain.head + site->gain.tail, 0.0);
        total += gain;
        mean[0] += gain * site->at.x.head;
        mean[1] += gain * site->at.y.head;
        mean[2] += gain * site->at.z.head;
    }
    off = pbw__max_abs(mean[0], mean[1], mean[2], 0.0);
    return total > 0.0 && total <= DBL_MAX && off <= (fine ? 1e-12 : 1e-14) * total
        && (fine > 1 || (dim == 3 ? size * size * size : size * size) * (fine ? 1e-11 : 1e-8) <= total);
}

/* Stores the unit of exact numbers: it divides all coordinates, and its square all weights. */
static void pbwq__cavity_unit(pbwq__cavity *cavity)
{
    const pbw_mesh *mesh = cavity->mesh;
    size_t i;
    for (cavity->unit = 2048, i = 0; i < cavity->sites && mesh->weights != NULL; i++) {
        cavity->unit = pbw__exact_unit(mesh->weights + cavity->site[i].vertex, 1, cavity->unit);
    }
    cavity->unit = pbw__exact_unit(cavity->query, mesh->dim, (cavity->unit - (cavity->unit & 1)) / 2);
    for (i = 0; i < cavity->sites; i++) {
        cavity->unit = pbw__exact_unit(mesh->points + cavity->site[i].vertex * (size_t)mesh->dim, mesh->dim,
                                       cavity->unit);
    }
}

static PBW__NOINLINE int pbwq__cavity_weigh_fine(int fine, int laplace, pbwq__scratch *scratch)
{
    const int weighted = scratch->cavity->mesh->weights != NULL, dim = scratch->cavity->mesh->dim;
    return fine == 1 ? PBW__BY_DIM(dim, pbwq__cavity_weigh, 1, weighted, laplace, scratch)
                     : PBW__BY_DIM(dim, pbwq__cavity_weigh, 2, weighted, laplace, scratch);
}

static int pbwq__cavity_weigh_coarse(int laplace, pbwq__scratch *scratch)
{
    const int weighted = scratch->cavity->mesh->weights != NULL, dim = scratch->cavity->mesh->dim;
    return weighted || laplace ? PBW__BY_DIM(dim, pbwq__cavity_weigh, 0, weighted, laplace, scratch)
                               : PBW__BY_DIM(dim, pbwq__cavity_weigh, 0, 0, 0, scratch);
}

/* Adds the list of a query: the sites with positive weights, by index. */
static void pbwq__cavity_write(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t query)
{
    pbwq__cavity *cavity = scratch->cavity;
    pbw_index *items;
    double *values, total = 0.0;
    size_t count = 0, i;
    for (i = 0; i < cavity->sites; i++) {
        const pbwq__site site = cavity->site[i];
        if (site.gain.head + site.gain.tail > 0.0) {
            cavity->site[count++] = site;
        }
    }
    items = pbwq__chunk_add(queries, scratch, block, query, count, &values);
    if (items == NULL) {
        return;
    }
    for (i = 0; i < count; i++) {
        items[i] = cavity->site[i].vertex;
        values[i] = cavity->site[i].gain.head + cavity->site[i].gain.tail;
    }
    pbwq__sort_items(items, values, count);
    for (i = 0; i < count; i++) {
        total += values[i];
    }
    for (i = 0; i < count; i++) {
        values[i] /= total;
    }
}

/* Adds Sibson's or Laplace's weights of a query inside simplex t. */
static void pbwq__coordinates_of(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t query, size_t t,
                                 const double *p)
{
    const pbw_mesh *mesh = queries->mesh;
    const int dim = mesh->dim, laplace = queries->scheme == PBW_LAPLACE;
    int right;
    if (scratch->cavity == NULL) {
        scratch->cavity = (pbwq__cavity *)pbw__allocate(scratch->memory, 1, sizeof(pbwq__cavity));
        if (scratch->cavity == NULL) {
            scratch->failed = 1;
            return;
        }
        memset(scratch->cavity, 0, sizeof(pbwq__cavity));
    }
    if (!(dim == 3 ? pbwq__cavity_find(queries, 3, scratch, t, p) : pbwq__cavity_find(queries, 2, scratch, t, p))) {
        return;
    }
    pbwq__cavity_relative(mesh, dim, scratch->cavity, p);
    right = pbwq__cavity_weigh_coarse(laplace, scratch);
    if (right == 0) {
        pbwq__cavity_unit(scratch->cavity);
        right = pbwq__cavity_weigh_fine(1, laplace, scratch);
    }
    if (right == 0) {
        right = pbwq__set_clear(scratch, &scratch->other) ? pbwq__cavity_weigh_fine(2, laplace, scratch) : -1;
    }
    if (right > 0) {
        pbwq__cavity_write(queries, scratch, block, query);
    } else if (right == 0) {
        const pbwq__location location = { t, 0, PBWQ__INSIDE, 0 };
        pbwq__barycentric(queries, scratch, block, query, &location, p);
    }
}

static void pbwq__coordinates_block(pbwq__queries *queries, pbwq__scratch *scratch, size_t block, size_t from,
                                    size_t to)
{
    const pbw_mesh *mesh = queries->mesh;
    const size_t dim = (size_t)mesh->dim;
    pbwq__location end = { 0, 0, 0, 0 };
    size_t i;
    for (i = from; i < to && !scratch->failed && !scratch->moved; i++) {
        const size_t query = pbwq__query_of(queries, i);
        pbwq__location location;
        unsigned spread, facets = 0;
        double p[4];
        int hull;
        pbw__fetch(&queries->input, query, p);
        if (i == from) {
            end.simplex = mesh->incident[pbwq__start_vertex(mesh, p)];
        }
        pbwq__walk_to(mesh, &end, p, &queries->grid);
        if (end.leave != PBWQ__INSIDE) {
            scratch->moved = end.leave == PBWQ__MOVED;
            continue;                                /* outside: an empty list */
        }
        location = end;
        location.simplex = pbwq__lowest_with(mesh, end.simplex, end.on, &hull);
        if (location.simplex != end.simplex) {
            const pbw_index *v = mesh->simplices + location.simplex * (dim + 1);
            (void)pbwq__side_exact(mesh, v, p, &queries->grid, &location.on);
        }
        for (spread = location.on; spread != 0; spread &= spread - 1) {
            facets++;
        }
        if (queries->scheme == PBW_BARYCENTRIC || hull || facets == dim
            || (mesh->weights != NULL && !pbwq__has_conflict(queries, mesh->dim, location.simplex, p, 0))) {
            pbwq__barycentric(queries, scratch, block, query, &location, p);
        } else {
            pbwq__coordinates_of(queries, scratch, block, query, location.simplex, p);
        }
        if (pbw__report(&queries->context, 0.0)) {
            return;
        }
    }
}

PBWDEF pbw_status pbw_coordinates(const pbw_mesh *mesh, const double *points, size_t count, pbw_scheme scheme,
                                  const pbw_options *options, pbw_lists *lists)
{
    pbwq__queries queries;
    pbw_status status;
    if (lists == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(lists, 0, sizeof(*lists));
    if (scheme != PBW_BARYCENTRIC && scheme != PBW_SIBSON && scheme != PBW_LAPLACE) {
        return PBW_ERROR_ARGUMENT;
    }
    status = pbwq__queries_start(&queries, mesh, points, count, options);
    if (status == PBW_OK) {
        queries.scheme = scheme;
        queries.with_values = 1;
        status = pbwq__make_lists(&queries, pbwq__coordinates_block, mesh->simplex_count == 0 ? 0 : count,
                                  PBWQ__BLOCK_QUERIES, count, lists);
    }
    return pbwq__lists_end(&queries, status, lists);
}
PBW__SEAM_END
#endif
#endif /* PBW_QUERY_IMPLEMENTATION */
