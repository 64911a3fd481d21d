/* pbw_check.h - v0.2.0 - proves a triangulation right, or says what is wrong with it - MIT-0

   QUICK START
   In the source file that defines PBW_IMPLEMENTATION, define PBW_CHECK_IMPLEMENTATION too; in others just include.

       #define PBW_IMPLEMENTATION
       #define PBW_CHECK_IMPLEMENTATION
       #include "pbw_check.h"
       #include <stdio.h>

       int main(void) {
           double points[] = { 0,0,  4,0,  0,4,  4,4,  1,2 };
           static pbw_mesh mesh;
           pbw_report report;
           pbw_status status = pbw_triangulate(2, points, NULL, 5, NULL, &mesh);
           if (status == PBW_OK) status = pbw_check(&mesh, NULL, &report);
           if (status != PBW_OK) { printf("%s\n", pbw_status_string(status)); return 1; }
           if (report.valid) printf("right: %u facets\n", (unsigned)report.facet_count);
           else printf("simplex %u: %s\n", report.simplex, report.what);
           pbw_free(&mesh);
           return 0;
       }

   Build:  cc -O2 quickstart.c -lpthread

   FUNCTIONS
     pbw_check  proves a mesh right, or says what is wrong

   CONTENTS  (search for the marks)
     >>interface  types and functions
     >>faults     the tests of a check, each of one point or simplex; its words
     >>check      the exact verdict on a finished mesh

   PROMISES  (and the test that guards each)
     exact       the verdict is by the true signs, for every finite double                  tests/test_check.c
     one answer  the same report for any number of threads                                  tests/test_threads.c
     the others  of pbw.h: never exits, re-entrant, bounded                                 tests/test_resources.c

   Words are those of pbw.h's GLOSSARY and CONVENTIONS.

   CONFIGURATION MACROS
     PBW_CHECK_IMPLEMENTATION   in the source file that has PBW_IMPLEMENTATION: compile the implementation there
     and those of pbw.h: PBW_STATIC and PBWDEF, PBW_NO_SIMD, PBW_NO_THREADS, PBW_WIDE
*/
#ifndef PBW_CHECK_H
#define PBW_CHECK_H
/* ------------------------------------------------------------------------------------------------------
   >>interface
   ------------------------------------------------------------------------------------------------------ */
#include "pbw.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Checks a mesh in O(n), exactly and independently of how it was built: indices, orientation, adjacency, local
   regularity of each facet under the tie rule, closure and convexity of the hull, single cover (hence Euler's
   relation), duplicates and hidden points.  Needs mesh->neighbors.  A faulty mesh is no error: the status is PBW_OK
   and report->valid is 0.  Of a mesh without simplices it checks that the points are PBW_DEGENERATE. */
PBWDEF pbw_status pbw_check(const pbw_mesh *mesh, const pbw_options *options, pbw_report *report);

#ifdef __cplusplus
}
#endif
#endif /* PBW_CHECK_H */

#if defined(PBW_CHECK_IMPLEMENTATION) && !defined(PBWCK__IMPLEMENTED)
#define PBWCK__IMPLEMENTED
#if PBW__SEAM != 1
#error "pbw_check.h is compiled where pbw.h of its version is: define PBW_IMPLEMENTATION too, above the include"
#else

PBW__SEAM_BEGIN
/* ------------------------------------------------------------------------------------------------------
   >>faults       The tests of >>check, a point or simplex each, and what they find, with its words; for CPU and GPU.
   In: a mesh and its points as records.  Out: 1, or 0 and the fault.  A thread without a pool may find
   PBWCK__FAULT_OPEN: no verdict yet.  Functions that are called for each simplex take the dimension as an argument,
   so that it is a constant there.
   ------------------------------------------------------------------------------------------------------ */
/* F(name, words) of each. */
#define PBWCK__FAULTS(F) \
    F(FINITE, "a coordinate or weight is not finite") \
    F(CANONICAL, "the canonical point is none") \
    F(PLACE, "a duplicate is not where its canonical point is") \
    F(RIGHT, "a duplicate has the better right to be canonical") \
    F(VERTEX, "a duplicate is a vertex") \
    F(INCIDENT, "the incident simplex of a vertex does not have it") \
    F(CORNER, "a corner is no point") \
    F(FIRST, "the incident simplex of a corner is not the first that has it") \
    F(NEGATIVE, "a simplex is negatively oriented") \
    F(FLAT, "a simplex is flat") \
    F(OVERLAP, "two simplices overlap, the first of the mesh and this") \
    F(INWARD, "a hull facet faces inward") \
    F(OTHER, "a neighbor is no other simplex") \
    F(BACK, "a neighbor does not name the simplex once") \
    F(FACET, "neighbors do not share the facet from opposite sides") \
    F(CONFLICT, "the corner across a facet is in conflict") \
    F(CONVEX, "the hull is not convex") \
    F(OUTSIDE, "a point outside the hull is no vertex") \
    F(REPEATED, "a point at a vertex is no duplicate of it") \
    F(UNHIDDEN, "a point that is no vertex is not hidden") \
    F(TWICE, "two points at one place are no duplicates") \
    F(SPAN, "the points span a simplex but there is none") \
    F(DUPLICATES, "duplicate_count is wrong") \
    F(HIDDEN, "hidden_count is wrong")
#define PBWCK__FAULT_NUMBER(name, words) , PBWCK__FAULT_##name
#define PBWCK__FAULT_WORDS(name, words) , words
enum { PBWCK__FAULT_OPEN = -1, PBWCK__SOUND PBWCK__FAULTS(PBWCK__FAULT_NUMBER) };
static const char *const pbwck__fault_words[] = { "" PBWCK__FAULTS(PBWCK__FAULT_WORDS) };

typedef struct pbwck__tested {                       /* a mesh */
    const pbw_index *simplices, *neighbors, *incident, *canonical;
    const double *record;                            /* of all points: coordinates, weight */
    size_t point_count, simplex_count;
    pbw__grid grid;
    int dim, linked;                                 /* linked: the neighbours are known to be sound */
} pbwck__tested;

typedef struct pbwck__finding {                      /* of a thread: the first fault, and what it counted before */
    pbw__digit *pool;                                /* room for the last exact stage, or NULL */
    int fault, facet;
    pbw_index simplex, point;
    size_t counted[3];                               /* vertices, others, duplicates; or facets, those of the hull */
} pbwck__finding;

PBW__INLINE int pbwck__find_fault(pbwck__finding *found, int fault, size_t simplex, int facet, size_t point)
{
    found->fault = fault;
    found->simplex = (pbw_index)simplex;
    found->facet = facet;
    found->point = (pbw_index)point;
    return 0;
}

PBW__INLINE const double *pbwck__test_record(const pbwck__tested *mesh, int dim, size_t point)
{
    return mesh->record + point * (size_t)(dim + 1);
}

PBW__INLINE void pbwck__test_corners(const pbwck__tested *mesh, int dim, size_t simplex, const double **x)
{
    int i;
    for (i = 0; i <= dim; i++) {
        x[i] = pbwck__test_record(mesh, dim, mesh->simplices[simplex * (size_t)(dim + 1) + (size_t)i]);
    }
}

/* Returns corner i of simplex 0; one that is no point is a fault that the tests find. */
PBW__INLINE const double *pbwck__test_basis(const pbwck__tested *mesh, int dim, int i)
{
    return pbwck__test_record(mesh, dim, mesh->simplices[i] < mesh->point_count ? mesh->simplices[i] : 0);
}

/* As pbw__side. */
PBW__INLINE int pbwck__test_side(const pbwck__tested *mesh, int dim, const double *const *x, int i, const double *p,
                                 pbw__digit *pool)
{
    const double *row[4] = { x[0], x[1], x[2], x[dim] };
    row[i] = p;
    return pbw__orient_in(pool, dim, row, &mesh->grid);
}

/* Returns whether the point o of >>check is on the inner side of a facet of the simplex x, or PBW__OPEN.  The
   point o is infinitely near a, then b, then c: the first of orient(facet, a), orient(facet, b), ... that is not 0
   decides, as an orientation is affine in o. */
PBW__DEVICE static PBW__NOINLINE int pbwck__faces_inside(const pbwck__tested *mesh, const double *const *x, int facet,
                                                         pbw__digit *pool)
{
    int sign = 0, i;
    for (i = 0; i <= mesh->dim && sign == 0; i++) {
        sign = pbwck__test_side(mesh, mesh->dim, x, facet, pbwck__test_basis(mesh, mesh->dim, i), pool);
    }
    return sign == PBW__OPEN ? PBW__OPEN : sign > 0;
}

/* Returns whether the simplex x holds o, which is infinitely close to a: so a must be in the closed box of x. */
PBW__INLINE int pbwck__test_covers(const pbwck__tested *mesh, int dim, const double *const *x, pbw__digit *pool)
{
    const double *a = pbwck__test_basis(mesh, dim, 0);
    int covers = 1, i, k;
    for (k = 0; k < dim; k++) {
        int below = 0, above = 0;
        for (i = 0; i <= dim; i++) {
            below |= x[i][k] <= a[k];
            above |= x[i][k] >= a[k];
        }
        if (!(below && above)) {
            return 0;
        }
    }
    for (i = 0; i <= dim && covers == 1; i++) {
        covers = pbwck__faces_inside(mesh, x, i, pool);
    }
    return covers;
}

PBW__INLINE int pbwck__test_point(const pbwck__tested *mesh, int dim, size_t p, pbwck__finding *found)
{
    const size_t kept = mesh->canonical[p], first = mesh->incident[p];
    if (kept == PBW_NONE && first == PBW_NONE) {     /* a free number of pbw_live_view */
        return 1;
    }
    if (kept >= mesh->point_count || mesh->canonical[kept] != kept) {
        return pbwck__find_fault(found, PBWCK__FAULT_CANONICAL, PBW_NONE, -1, p);
    }
    if (kept != p) {
        const double *x = pbwck__test_record(mesh, dim, p), *y = pbwck__test_record(mesh, dim, kept);
        if (!pbw__same_place(x, y, dim)) {
            return pbwck__find_fault(found, PBWCK__FAULT_PLACE, PBW_NONE, -1, p);
        }
        if (x[dim] != y[dim] ? x[dim] > y[dim] : p < kept) {
            return pbwck__find_fault(found, PBWCK__FAULT_RIGHT, PBW_NONE, -1, p);
        }
        if (first != PBW_NONE) {
            return pbwck__find_fault(found, PBWCK__FAULT_VERTEX, first, -1, p);
        }
        found->counted[2]++;
    } else if (first != PBW_NONE) {
        int has = 0, k;
        for (k = 0; k <= dim && first < mesh->simplex_count; k++) {
            has |= mesh->simplices[first * (size_t)(dim + 1) + (size_t)k] == p;
        }
        if (!has) {
            return pbwck__find_fault(found, PBWCK__FAULT_INCIDENT, first, -1, p);
        }
        found->counted[0]++;
    } else {
        found->counted[1]++;
    }
    return 1;
}

/* Have v without corner i and u without corner j the same vertices, and does v with u[j] for v[i] become u by an odd
   permutation?  Then u[j] and v[i] are on opposite sides of the facet, given that v and u are positively oriented.
   The parity is that of the facet's vertices, and of the ways of i and j to the end. */
PBW__INLINE int pbwck__facets_match(const pbw_index *v, int i, const pbw_index *u, int j, int dim)
{
    int place[3], found = 0, odd = (i + j) & 1, k, m;
    for (k = 0; k < dim; k++) {
        pbw_index vertex = v[k + (k >= i)];
        place[k] = 0;
        for (m = 0; m <= dim; m++) {
            int here = u[m] == vertex && m != j;
            place[k] += here ? m : 0;
            found += here;
        }
        for (m = 0; m < k; m++) {
            odd ^= place[m] > place[k];
        }
    }
    return odd && found == dim;
}

/* Tests facet i of simplex s.  The ids of the corners of s are right.  A facet between two simplices is compared and
   tested once, from the one of higher number. */
PBW__INLINE int pbwck__test_facet(const pbwck__tested *mesh, int dim, size_t s, int i, const double *const *x,
                                  pbwck__finding *found)
{
    const size_t corners = (size_t)dim + 1;
    const pbw_index t = mesh->neighbors[s * corners + (size_t)i], *u, *back;
    int links = 0, j = 0, m;
    if (t == PBW_NONE) {
        found->counted[0]++;
        found->counted[1]++;
        m = pbwck__faces_inside(mesh, x, i, found->pool);
        return m == 1 || pbwck__find_fault(found, m == PBW__OPEN ? PBWCK__FAULT_OPEN : PBWCK__FAULT_INWARD, s, i,
                                           PBW_NONE);
    }
    if (t >= mesh->simplex_count || t == s) {
        return pbwck__find_fault(found, PBWCK__FAULT_OTHER, s, i, PBW_NONE);
    }
    if (mesh->linked && t > s) {
        return 1;
    }
    u = mesh->simplices + t * corners;
    back = mesh->neighbors + t * corners;
    for (m = 0; m <= dim; m++) {
        links += back[m] == s;
        j = back[m] == s ? m : j;
    }
    if (links != 1) {
        return pbwck__find_fault(found, PBWCK__FAULT_BACK, s, i, PBW_NONE);
    }
    if (t > s) {
        return 1;
    }
    found->counted[0]++;
    if (u[j] >= mesh->point_count) {
        return 1;                                    /* another test's to tell: t comes before s */
    }
    if (!pbwck__facets_match(mesh->simplices + s * corners, i, u, j, dim)) {
        return pbwck__find_fault(found, PBWCK__FAULT_FACET, s, i, PBW_NONE);
    }
    m = pbw__conflict_in(found->pool, dim, x, pbwck__test_record(mesh, dim, u[j]), &mesh->grid);
    return m == 0 || pbwck__find_fault(found, m == PBW__OPEN ? PBWCK__FAULT_OPEN : PBWCK__FAULT_CONFLICT, s, i, u[j]);
}

PBW__INLINE int pbwck__test_simplex(const pbwck__tested *mesh, int dim, size_t s, pbwck__finding *found)
{
    const pbw_index *v = mesh->simplices + s * (size_t)(dim + 1);
    const double *x[4];
    int i, sign, sound = 1;
    for (i = 0; i <= dim; i++) {
        if (v[i] >= mesh->point_count) {
            return pbwck__find_fault(found, PBWCK__FAULT_CORNER, s, -1, v[i]);
        }
        if (mesh->incident[v[i]] > s) {              /* PBW_NONE is; that it has v[i] is known */
            return pbwck__find_fault(found, PBWCK__FAULT_FIRST, s, -1, v[i]);
        }
    }
    pbwck__test_corners(mesh, dim, s, x);
    sign = pbw__orient_in(found->pool, dim, x, &mesh->grid);
    if (sign != 1) {
        return pbwck__find_fault(found, sign == PBW__OPEN ? PBWCK__FAULT_OPEN
                                      : sign < 0 ? PBWCK__FAULT_NEGATIVE : PBWCK__FAULT_FLAT, s, -1, PBW_NONE);
    }
    sign = s > 0 ? pbwck__test_covers(mesh, dim, x, found->pool) : 0;  /* simplex 0 holds o: it is oriented */
    if (sign != 0) {
        return pbwck__find_fault(found, sign == PBW__OPEN ? PBWCK__FAULT_OPEN : PBWCK__FAULT_OVERLAP, s, -1,
                                 PBW_NONE);
    }
    for (i = 0; i <= dim && sound; i++) {
        sound = pbwck__test_facet(mesh, dim, s, i, x, found);
    }
    return sound;
}

/* A way around a ridge, from simplex to simplex: `in` is across from the facet by which the ridge's next simplex was
   entered, `out` across from the one by which it is left.  Each simplex around a ridge has one predecessor and one
   successor there, so the way from a hull facet cannot close: it ends at another. */
typedef struct pbwck__turn { size_t simplex; int in, out; } pbwck__turn;

/* Goes on to the next simplex; returns 0 at the hull. */
PBW__INLINE int pbwck__turn_on(const pbwck__tested *mesh, int dim, pbwck__turn *turn)
{
    const size_t corners = (size_t)dim + 1;
    const pbw_index *v = mesh->simplices, *n = mesh->neighbors;
    const size_t next = n[turn->simplex * corners + (size_t)turn->out];
    size_t entry = 0, exit = 0;
    if (next == PBW_NONE) {
        return 0;
    }
    while (n[next * corners + entry] != turn->simplex) {
        entry++;
    }
    while (v[next * corners + exit] != v[turn->simplex * corners + (size_t)turn->in]) {
        exit++;
    }
    turn->simplex = next;
    turn->in = (int)entry;
    turn->out = (int)exit;
    return 1;
}

/* The ridge between facet i of simplex s and another hull facet, where the way around it has ended; tested from the
   simplex of lower number. */
PBW__INLINE int pbwck__test_ridge(const pbwck__tested *mesh, int dim, size_t s, int i, const pbwck__turn *end,
                                  pbwck__finding *found)
{
    const pbw_index apex = mesh->simplices[end->simplex * (size_t)(dim + 1) + (size_t)end->in];
    const double *x[4] = { NULL };
    int sign;
    if (end->simplex < s) {
        return 1;
    }
    pbwck__test_corners(mesh, dim, s, x);
    sign = pbwck__test_side(mesh, dim, x, i, pbwck__test_record(mesh, dim, apex), found->pool);
    return (sign >= 0 && sign != PBW__OPEN)
        || pbwck__find_fault(found, sign < 0 ? PBWCK__FAULT_CONVEX : PBWCK__FAULT_OPEN, s, i, apex);
}

/* A visibility walk to a point that is no vertex. */
typedef struct pbwck__visit { pbw_index point, here, last; } pbwck__visit;

/* Goes on to the next simplex; returns 0 where the walk ends, then facet is the one that the point is beyond, -1 if
   none, or the fault is open. */
PBW__INLINE int pbwck__visit_on(const pbwck__tested *mesh, int dim, pbwck__visit *visit, pbwck__finding *found)
{
    const pbw_index *next = mesh->neighbors + visit->here * (size_t)(dim + 1);
    const double *p = pbwck__test_record(mesh, dim, visit->point), *x[4] = { NULL };
    int sign = 0, i;
    pbwck__test_corners(mesh, dim, visit->here, x);
    for (i = 0; i <= dim; i++) {
        sign = next[i] == visit->last ? 0 : pbwck__test_side(mesh, dim, x, i, p, found->pool);
        if (sign < 0 || sign == PBW__OPEN) {
            break;
        }
    }
    if (i > dim || sign == PBW__OPEN || next[i] == PBW_NONE) {
        return pbwck__find_fault(found, sign == PBW__OPEN ? PBWCK__FAULT_OPEN : PBWCK__SOUND, visit->here,
                                 i > dim ? -1 : i, visit->point);
    }
    visit->last = visit->here;
    visit->here = next[i];
    return 1;
}

/* The point, where the walk to it has ended. */
PBW__INLINE int pbwck__test_visited(const pbwck__tested *mesh, int dim, const pbwck__visit *visit,
                                    pbwck__finding *found)
{
    const double *p = pbwck__test_record(mesh, dim, visit->point), *x[4] = { NULL };
    int verdict, i;
    if (found->fault == PBWCK__FAULT_OPEN) {
        return 0;
    }
    if (found->facet >= 0) {
        return pbwck__find_fault(found, PBWCK__FAULT_OUTSIDE, visit->here, found->facet, visit->point);
    }
    pbwck__test_corners(mesh, dim, visit->here, x);
    for (i = 0; i <= dim; i++) {
        if (pbw__same_place(p, x[i], dim)) {
            return pbwck__find_fault(found, PBWCK__FAULT_REPEATED, visit->here, -1, visit->point);
        }
    }
    verdict = pbw__conflict_in(found->pool, dim, x, p, &mesh->grid);
    return verdict == 0 || pbwck__find_fault(found, verdict == PBW__OPEN ? PBWCK__FAULT_OPEN : PBWCK__FAULT_UNHIDDEN,
                                             visit->here, -1, visit->point);
}

/* ------------------------------------------------------------------------------------------------------
   >>check        The exact verdict on a finished mesh.
   In: the public arrays of a mesh.  Out: a report; the first fault has a name and a place.
   Shared with the construction: the exact signs, the allocator, the threads, and the keys of the Hilbert curve and
   their sort, with which points are listed that no simplex has.  Expected linear time: three passes over points and
   simplices, and walks to hidden points in the order of the curve.  Memory: dim+1 doubles a point, 16 bytes a hidden
   point.  A pass is cut into ranges of one size; the fault of the first range that has one is reported, with what was
   counted before, so the report is the same for every number of threads.

   What is tested, and why it is enough.  Write d for the dimension.

   Simplices, facets.  Each simplex is positively oriented.  Each facet has no neighbour, then it is a hull facet;
   or two simplices share it, each names the other once, and their far corners are on opposite sides: that is a
   parity, as both are positive.  For a point x on no facet let N(x) be the number of simplices that hold x.  On
   the way through a shared facet one simplex is left and one is entered; so N changes at hull facets only, by one
   for each.

   Hull, cover.  Let o be the point a + e(b-a) + e^2(c-a) + ..., e infinitesimal, in simplex 0 = a b c ...: it is
   strictly inside, and in no fixed hyperplane at all.  Tested: each hull facet has o strictly on its inner side,
   and N(o) = 1.  A generic ray from o leaves one simplex for nothing at each hull facet that it meets: there N
   falls by one.  It never rises, and is 0 at last; so the ray meets exactly N(o) = 1 hull facets.  Hence the hull
   facets bound a body K that is star-shaped about o, and N is 1 in K and 0 outside: the simplices tile K, once.

   Convexity.  Two hull facets that follow each other around a ridge, found by turning about it through the
   simplices, induce opposite orientations on it and both have o inside; so, seen from o, they leave it to
   different sides: no facet folds back onto its neighbour, not even in its plane.  Tested: the far corner of one
   is not strictly outside the other.  Cut K by the plane through o and two of its points x, y in general
   position: the section is a polygon, star-shaped about o; its corners lie on ridges only and have angles of at
   most pi.  So it is convex and holds the segment xy; by continuity, K is convex.  (Mehlhorn et al. 1999,
   "Checking geometric programs or verification of geometric structures", test polytopes in this way.  The
   simplices inside spare us the theorems on immersed locally convex surfaces, van Heijenoort 1952.)  Euler's
   relation is a consequence, and so is that no two vertices are at one place: the star of either would cover the
   part of K around it.

   Regularity.  Let F be the function on K that is affine on each simplex and equals the lift |p|^2 - w at the
   vertices, the lifts perturbed (finitely many signs are concerned, so one small positive perturbation serves
   all).  Tested: across each shared facet the far corner lies strictly above the hyperplane of the lifted
   simplex.  So F is convex along each segment that avoids the faces of dimension d-2, by continuity it is convex,
   and it bends strictly at each facet: it is the lower hull of the lifted vertices, and the simplices are the
   regular triangulation of the vertices (Edelsbrunner and Shah 1996, "Incremental topological flipping works for
   regular triangulations").

   Other points.  A duplicate has the place of its canonical point and no better right to be it.  Any other point
   that is no vertex must lie in K and have its lift above F, else it would be a vertex.  F is continuous, so any
   one simplex that has the point inside or on its boundary decides, be it on a shared facet or on the hull.  The
   walk there crosses facets between the simplex and the point only, and in a regular triangulation such a walk
   never comes back (Edelsbrunner 1990, "An acyclicity theorem for cell complexes in d dimensions"), so it ends.
   These points are pairwise at different places: those of equal hash are compared; and at no vertex: they are
   compared with the corners of their simplex.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwck__check {
    const pbw_mesh *mesh;
    pbw_report *report;
    pbw__context *context;
    pbwck__tested tested;
    double *record;                                  /* tested.record, while it is filled */
    pbwck__finding found;                            /* in the last pass: its first fault; what it counted before */
    const double *basis[4];                          /* degenerate: independent points */
    int dim, rank;                                   /* points in the basis */
    size_t *others;                                  /* in each range of points; then where to list them */
    size_t other_count;                              /* others are canonical, but no vertices */
    uint64_t *by_hash, *other;                       /* each other point, as sort key << 32 | point */
    pbw__box box;                                    /* of the others */
    pbw__curve curve;
    pbw_status status;
} pbwck__check;

typedef struct pbwck__part {                         /* what is found in one range of a pass */
    pbwck__finding found;
    pbw__box box;                                    /* of the others; empty in other passes */
    pbw_index hint;                                  /* where the last walk ended */
} pbwck__part;

/* Checks the items from, ..., to - 1; returns 0 at a fault, or if cancelled. */
typedef int pbwck__items(pbwck__check *check, pbwck__part *part, size_t from, size_t to);

typedef struct pbwck__checking {
    pbwck__check *check;
    pbwck__items *items;
    pbwck__part *part;                               /* one for each range of PBWCK__CHECKED items */
} pbwck__checking;
#define PBWCK__CHECKED ((size_t)1024)

static int pbwck__fault(pbw_report *report, int fault, size_t simplex, int facet, size_t point)
{
    report->what = pbwck__fault_words[fault];
    report->simplex = (pbw_index)simplex;
    report->facet = (pbw_index)facet;
    report->point = (pbw_index)point;
    return 0;
}

static pbw_status pbwck__range(void *arg, size_t from, size_t to)
{
    const pbwck__checking *checking = (const pbwck__checking *)arg;
    pbw__digit pool[PBW__POOL];
    pbwck__part part;                                /* on the stack: no false sharing with other tasks */
    int sound;
    memset(&part, 0, sizeof(part));
    part.found.pool = pool;
    pbw__box_reset(&part.box, 0);
    sound = checking->items(checking->check, &part, from, to);
    part.found.pool = NULL;
    checking->part[from / PBWCK__CHECKED] = part;
    return sound ? PBW_OK : PBW_DEGENERATE;
}

/* One pass over count items; progress goes on to `end`.  Returns 0 to stop: a fault, cancelled, or out of memory. */
static int pbwck__pass(pbwck__check *check, pbwck__items *items, size_t count, double end)
{
    const size_t parts = count / PBWCK__CHECKED + 1;
    pbwck__checking checking = { check, items, NULL };
    pbwck__finding *found = &check->found;
    pbw_status status;
    size_t i;
    int k;
    checking.part = (pbwck__part *)pbw__allocate_large(check->context, parts, sizeof(pbwck__part));
    if (checking.part == NULL) {
        check->status = PBW_ERROR_MEMORY;
        return 0;
    }
    memset(checking.part, 0, parts * sizeof(pbwck__part));
    memset(found->counted, 0, sizeof(found->counted));
    status = pbw__for_range(check->context, count, PBWCK__CHECKED, end, pbwck__range, &checking);
    for (i = 0; i * PBWCK__CHECKED < count && found->fault == PBWCK__SOUND; i++) {
        const pbwck__part *part = checking.part + i;
        for (k = 0; k < 3; k++) {
            found->counted[k] += part->found.counted[k];
        }
        if (part->box.low[0] <= part->box.high[0]) {
            pbw__box_add(&check->box, part->box.low, check->dim);
            pbw__box_add(&check->box, part->box.high, check->dim);
        }
        if (part->found.fault != PBWCK__SOUND) {
            (void)pbwck__find_fault(found, part->found.fault, part->found.simplex, part->found.facet,
                                    part->found.point);
        }
    }
    pbw__release(&check->context->memory, checking.part, parts, sizeof(pbwck__part));
    return status == PBW_OK;
}

/* The points as records. */
static int pbwck__finite(pbwck__check *check, pbwck__part *part, size_t from, size_t to)
{
    const pbw_mesh *mesh = check->mesh;
    const double *w = mesh->weights;
    const size_t dim = (size_t)check->dim;
    size_t p, k;
    for (p = from; p < to; p++) {
        double *x = check->record + p * (dim + 1);
        for (k = 0; k <= dim; k++) {
            x[k] = (k < dim ? mesh->points[p * dim + k] : w != NULL ? w[p] : 0.0) + 0.0;
            if (!(x[k] - x[k] == 0.0)) {
                return pbwck__find_fault(&part->found, PBWCK__FAULT_FINITE, PBW_NONE, -1, p);
            }
        }
    }
    return 1;
}

static int pbwck__points(pbwck__check *check, pbwck__part *part, size_t from, size_t to)
{
    size_t *others = check->others + from / PBWCK__CHECKED;
    int sound = 1;
    for (; from < to && sound; from++) {
        sound = pbwck__test_point(&check->tested, check->dim, from, &part->found);
    }
    *others = part->found.counted[1];
    return sound;
}

static int pbwck__simplices(pbwck__check *check, pbwck__part *part, size_t from, size_t to)
{
    int sound = 1;
    for (; from < to && sound; from++) {
        sound = check->dim == 2 ? pbwck__test_simplex(&check->tested, 2, from, &part->found)
                                : pbwck__test_simplex(&check->tested, 3, from, &part->found);
    }
    return sound;
}

static int pbwck__hull(pbwck__check *check, pbwck__part *part, size_t from, size_t to)
{
    const pbwck__tested *mesh = &check->tested;
    const int dim = check->dim;
    size_t steps = 0, s;
    int i, k;
    for (s = from; s < to; s++) {
        for (i = 0; i <= dim; i++) {
            for (k = 0; k <= dim && mesh->neighbors[s * (size_t)(dim + 1) + (size_t)i] == PBW_NONE; k++) {
                pbwck__turn turn = { s, i, k };
                if (k == i) {
                    continue;
                }
                while (pbwck__turn_on(mesh, dim, &turn)) {
                    if ((++steps & (PBW__TICK - 1)) == 0 && pbw__report(check->context, 0.85)) {
                        return 0;                    /* a single ridge may have them all */
                    }
                }
                if (!pbwck__test_ridge(mesh, dim, s, i, &turn, &part->found)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Visibility walk to each of the other points, from where the last one ended. */
static int pbwck__hidden(pbwck__check *check, pbwck__part *part, size_t from, size_t to)
{
    size_t steps = 0;
    while (from < to) {
        pbwck__visit visit = { (uint32_t)check->other[from], part->hint, part->hint };
        while (pbwck__visit_on(&check->tested, check->dim, &visit, &part->found)) {
            if ((++steps & 1023) == 0 && pbw__report(check->context, 0.94)) {
                return 0;
            }
        }
        if (pbwck__test_visited(&check->tested, check->dim, &visit, &part->found)) {
            part->hint = visit.here;
            from++;
        } else if (part->hint != 0) {
            part->hint = 0;                          /* reported as a walk from simplex 0 finds it, in every part */
        } else {
            return 0;
        }
    }
    return 1;
}

/* Stops at the first point that is independent of the basis. */
static int pbwck__flat(pbwck__check *check, pbwck__part *part, size_t from, size_t to)
{
    const double *a[4] = { check->basis[0], check->basis[1], check->basis[2], NULL };
    for (; from < to; from++) {
        const double *x = pbwck__test_record(&check->tested, check->dim, from);
        a[check->dim] = x;
        if (check->mesh->canonical[from] == PBW_NONE) {
            continue;
        }
        if (check->rank == check->dim ? pbw__orient(check->dim, a, &check->tested.grid) != 0
            : check->rank == 2 ? !pbw__collinear3(a[0], a[1], x, &check->tested.grid)
                               : check->rank == 0 || !pbw__same_place(a[0], x, check->dim)) {
            return pbwck__find_fault(&part->found, PBWCK__FAULT_SPAN, PBW_NONE, -1, from);
        }
    }
    return 1;
}

/* No simplices: all points lie in the hyperplane of the first that are independent, if there are dim of them. */
static int pbwck__span(pbwck__check *check)
{
    for (;;) {
        const int going = pbwck__pass(check, pbwck__flat, check->mesh->point_count, 0.9);
        if (check->found.fault != PBWCK__FAULT_SPAN || check->rank == check->dim) {
            return going;
        }
        check->basis[check->rank++] = pbwck__test_record(&check->tested, check->dim, check->found.point);
        (void)pbwck__find_fault(&check->found, PBWCK__SOUND, PBW_NONE, -1, PBW_NONE);
    }
}

/* Lists the points of a range that are neither duplicates nor vertices. */
static int pbwck__gather(pbwck__check *check, pbwck__part *part, size_t from, size_t to)
{
    size_t next = check->others[from / PBWCK__CHECKED];
    for (; from < to; from++) {
        if (check->mesh->canonical[from] == from && check->mesh->incident[from] == PBW_NONE) {
            const double *x = pbwck__test_record(&check->tested, check->dim, from);
            check->by_hash[next++] = (pbw__hash_doubles(0, x, check->dim) & ~(uint64_t)UINT32_MAX) | (uint64_t)from;
            pbw__box_add(&part->box, x, check->dim);
        }
    }
    return 1;
}

/* Points of equal hash must be at different places; then lists the points by the keys of the Hilbert curve. */
static int pbwck__apart(pbwck__check *check, pbwck__part *part, size_t from, size_t to)
{
    const uint64_t *key = check->by_hash;
    size_t k, m;
    for (k = from; k < to; k++) {
        const double *x = pbwck__test_record(&check->tested, check->dim, (uint32_t)key[k]);
        for (m = k + 1; m < check->other_count && key[m] >> 32 == key[k] >> 32; m++) {
            uint32_t p = (uint32_t)key[m];
            if (pbw__same_place(x, pbwck__test_record(&check->tested, check->dim, p), check->dim)) {
                return pbwck__find_fault(&part->found, PBWCK__FAULT_TWICE, PBW_NONE, -1, p);
            }
        }
        check->other[k] = pbw__hilbert_key(check->curve.step, &check->box, x, check->dim,
                                           check->curve.levels) << 32 | (uint32_t)key[k];
    }
    return 1;
}

/* Checks the points that are neither duplicates nor vertices.  Returns 0 to stop: a fault, cancelled, or no
   memory. */
static int pbwck__others(pbwck__check *check)
{
    pbw__context *context = check->context;
    pbw_memory *memory = &context->memory;
    const size_t count = check->other_count;
    const int bits = check->dim == 2 ? 16 : 10, tasks = pbw__tasks(context, count, 16384);
    uint64_t *keys = (uint64_t *)pbw__allocate(memory, count, sizeof(uint64_t));
    uint64_t *spare = (uint64_t *)pbw__allocate(memory, count, sizeof(uint64_t));
    uint32_t *start = (uint32_t *)pbw__allocate(memory, ((size_t)tasks + 1) * PBW__DIGITS, sizeof(uint32_t));
    pbw__sorting sorting = { context, keys, spare, start, count, tasks, 0, 0 };
    int going = 0;
    if (keys == NULL || spare == NULL || start == NULL) {
        check->status = PBW_ERROR_MEMORY;
    } else {
        pbw__curve_create(&check->curve, count, check->dim);
        pbw__box_reset(&check->box, bits);
        check->by_hash = keys;
        going = pbwck__pass(check, pbwck__gather, check->mesh->point_count, 0.92)
            && (check->by_hash = pbw__sort_by(&sorting, 32, 32)) != NULL;
        if (going) {
            pbw__box_close(&check->box, check->dim);
            check->box.extent = check->box.extent > 0.0 ? check->box.extent : 1.0;
            check->other = check->by_hash == keys ? spare : keys;
            going = pbwck__pass(check, pbwck__apart, count, 0.94);
        }
        if (going && check->mesh->simplex_count > 0) {
            sorting.a = check->other;
            sorting.b = check->by_hash;
            check->other = pbw__sort_by(&sorting, 32, bits * check->dim);
            going = check->other != NULL && pbwck__pass(check, pbwck__hidden, count, 1.0);
        }
    }
    pbw__release(memory, keys, count, sizeof(uint64_t));
    pbw__release(memory, spare, count, sizeof(uint64_t));
    pbw__release(memory, start, ((size_t)tasks + 1) * PBW__DIGITS, sizeof(uint32_t));
    return going;
}

/* The grid of records that exist already. */
typedef struct pbwck__grid_scanning {
    const double *records;
    int dim;
    size_t grain;
    pbw__grid_share share[64];                       /* of each range */
} pbwck__grid_scanning;

static pbw_status pbwck__grid_scan_range(void *arg, size_t from, size_t to)
{
    pbwck__grid_scanning *scanning = (pbwck__grid_scanning *)arg;
    pbw__grid_share *share = scanning->share + from / scanning->grain;
    pbw__grid_share_reset(share);
    pbw__grid_add(share, scanning->records + from * (size_t)(scanning->dim + 1), to - from, scanning->dim,
                  scanning->dim + 1);
    return PBW_OK;
}

static void pbwck__grid_scan(pbw__context *context, const double *records, size_t count, int dim, pbw__grid *grid)
{
    pbwck__grid_scanning scanning;
    memset(grid, 0, sizeof(*grid));
    scanning.records = records;
    scanning.dim = dim;
    scanning.grain = count / 64 + PBW__TICK;
    if (pbw__for_range(context, count, scanning.grain, 0.0, pbwck__grid_scan_range, &scanning) == PBW_OK) {
        pbw__grid_close(grid, scanning.share, (int)((count + scanning.grain - 1) / scanning.grain), dim);
    }
}

static int pbwck__all(pbwck__check *check)
{
    const pbw_mesh *mesh = check->mesh;
    const size_t points = mesh->point_count, simplices = mesh->simplex_count;
    int going = pbwck__pass(check, pbwck__finite, points, 0.05)
        && pbwck__pass(check, pbwck__points, points, 0.1);
    size_t i;
    check->report->vertex_count = check->found.counted[0];
    if (!going) {
        return 0;
    }
    if (check->found.counted[2] != mesh->duplicate_count) {
        return pbwck__find_fault(&check->found, PBWCK__FAULT_DUPLICATES, PBW_NONE, -1, PBW_NONE);
    }
    for (i = 0; i * PBWCK__CHECKED < points; i++) {
        const size_t others = check->others[i];
        check->others[i] = check->other_count;
        check->other_count += others;
    }
    if (mesh->hidden_count != (simplices > 0 ? check->other_count : 0)) {
        return pbwck__find_fault(&check->found, PBWCK__FAULT_HIDDEN, PBW_NONE, -1, PBW_NONE);
    }
    pbwck__grid_scan(check->context, check->record, points, check->dim, &check->tested.grid);
    if (simplices == 0) {
        return pbwck__span(check) && pbwck__others(check);
    }
    going = pbwck__pass(check, pbwck__simplices, simplices, 0.85);
    check->report->facet_count = check->found.counted[0];
    check->report->hull_facet_count = check->found.counted[1];
    return going && pbwck__pass(check, pbwck__hull, simplices, 0.9)
        && (check->other_count == 0 || pbwck__others(check));
}

PBWDEF pbw_status pbw_check(const pbw_mesh *mesh, const pbw_options *options, pbw_report *report)
{
    pbw__context context;
    pbwck__check check;
    size_t size, ranges;
    if (report == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(report, 0, sizeof(*report));
    (void)pbwck__fault(report, PBWCK__SOUND, PBW_NONE, -1, PBW_NONE);
    if (!pbw__has_arrays(mesh, 1)) {
        return PBW_ERROR_ARGUMENT;
    }
    if (mesh->point_count >= PBW_NONE || mesh->simplex_count >= PBW_NONE) {
        return PBW_ERROR_TOO_LARGE;
    }
    memset(&check, 0, sizeof(check));
    (void)pbwck__find_fault(&check.found, PBWCK__SOUND, PBW_NONE, -1, PBW_NONE);
    check.mesh = mesh;
    check.report = report;
    check.context = &context;
    check.dim = check.tested.dim = mesh->dim;
    check.tested.simplices = mesh->simplices;
    check.tested.neighbors = mesh->neighbors;
    check.tested.incident = mesh->incident;
    check.tested.canonical = mesh->canonical;
    check.tested.point_count = mesh->point_count;
    check.tested.simplex_count = mesh->simplex_count;
    check.status = pbw__begin_call(&context, options, mesh->point_count);
    if (check.status == PBW_OK && !pbw__enter_stage(&context, PBW_STAGE_CHECK)) {
        size = (size_t)(mesh->dim + 1) * sizeof(double);
        ranges = mesh->point_count / PBWCK__CHECKED + 1;
        check.record = (double *)pbw__allocate_large(&context, mesh->point_count, size);
        check.tested.record = check.record;
        check.others = (size_t *)pbw__allocate(&context.memory, ranges, sizeof(size_t));
        check.status = check.record != NULL && check.others != NULL ? PBW_OK : PBW_ERROR_MEMORY;
        report->valid = check.status == PBW_OK && pbwck__all(&check);
        (void)pbwck__fault(report, check.found.fault, check.found.simplex, check.found.facet, check.found.point);
        pbw__release(&context.memory, check.record, mesh->point_count, size);
        pbw__release(&context.memory, check.others, ranges, sizeof(size_t));
    }
    check.status = pbw__end_call(&context, context.cancelled ? PBW_CANCELLED : check.status);
    report->valid &= check.status == PBW_OK;
    return check.status;
}
PBW__SEAM_END
#endif
#endif /* PBW_CHECK_IMPLEMENTATION */
