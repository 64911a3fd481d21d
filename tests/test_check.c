/* test_check.c: pbw_check finds and names planted faults, and finds no others; pbw_hash tells triangulations apart.

   The meshes with planted faults come from an enumeration of all simplices in integer arithmetic, which shares
   nothing with the library, so the verdict is tested both ways: valid if and only if the enumeration says so. */
#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200112L
#endif
#include "pbw_check.h"
#include "inputs.h"
#include "meter.h"
#include "test.h"
#include "watch.h"
#include <fenv.h>
#include <pthread.h>
#ifdef __SSE2__
#include <immintrin.h>
#endif

enum { MAX_POINTS = 40, MAX_SIMPLICES = 400 };

typedef struct model {
    pbw_mesh mesh;                                   /* its arrays are those below */
    double points[3 * MAX_POINTS], weights[MAX_POINTS];
    pbw_index simplices[4 * MAX_SIMPLICES], neighbors[4 * MAX_SIMPLICES];
    pbw_index incident[MAX_POINTS], canonical[MAX_POINTS];
} model;

static uint64_t state;                               /* of the random numbers */

/* ---- the enumeration ---- */

static void model_attach(model *m, int weighted)
{
    m->mesh.points = m->points;
    m->mesh.weights = weighted ? m->weights : NULL;
    m->mesh.simplices = m->simplices;
    m->mesh.neighbors = m->neighbors;
    m->mesh.incident = m->incident;
    m->mesh.canonical = m->canonical;
}

static void model_copy(model *to, const model *from)
{
    memcpy(to, from, sizeof *to);
    model_attach(to, from->mesh.weights != NULL);
}

static int64_t coordinate(const model *m, pbw_index p, int k)
{
    return (int64_t)m->points[(int)p * m->mesh.dim + k];
}

static int64_t weight(const model *m, pbw_index p)
{
    return m->mesh.weights != NULL ? (int64_t)m->weights[p] : 0;
}

/* Twice the area or six times the volume. */
static int64_t volume(const model *m, const pbw_index *v)
{
    int64_t d[3][3] = { { 0 } };
    int i, k;
    for (i = 0; i < m->mesh.dim; i++) {
        for (k = 0; k < m->mesh.dim; k++) {
            d[i][k] = coordinate(m, v[i + 1], k) - coordinate(m, v[0], k);
        }
    }
    if (m->mesh.dim == 2) {
        return d[0][0] * d[1][1] - d[0][1] * d[1][0];
    }
    return d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) - d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0])
         + d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
}

static int lexicographic(const model *m, pbw_index p, pbw_index q)
{
    int k;
    for (k = 0; k < m->mesh.dim; k++) {
        if (coordinate(m, p, k) != coordinate(m, q, k)) {
            return coordinate(m, p, k) < coordinate(m, q, k) ? -1 : 1;
        }
    }
    return 0;
}

static int64_t lift(const model *m, pbw_index p)
{
    int64_t sum = -weight(m, p);
    int k;
    for (k = 0; k < m->mesh.dim; k++) {
        sum += coordinate(m, p, k) * coordinate(m, p, k);
    }
    return sum;
}

/* The rule of ties as in CONVENTIONS, or with the lifts lowered instead of raised. */
static int conflict(const model *m, const pbw_index *v, pbw_index p, int lowered)
{
    int64_t part[4], sum = -volume(m, v) * lift(m, p);
    int i, dim = m->mesh.dim, used = 0;
    for (i = 0; i <= dim; i++) {
        pbw_index u[4];
        memcpy(u, v, sizeof u);
        u[i] = p;
        part[i] = volume(m, u);
        sum += part[i] * lift(m, v[i]);
    }
    while (sum == 0) {
        int top = -1;
        for (i = 0; i <= dim; i++) {
            if (!(used >> i & 1) && (top < 0 || lexicographic(m, v[i], v[top]) > 0)) {
                top = i;
            }
        }
        if (top < 0 || lexicographic(m, p, v[top]) > 0) {
            return lowered;
        }
        used |= 1 << top;
        sum = lowered ? -part[top] : part[top];
    }
    return sum > 0;
}

/* Neighbours and incident simplices of what is in m->simplices. */
static void model_connect(model *m)
{
    size_t corners = (size_t)m->mesh.dim + 1, count = m->mesh.simplex_count, s, t, i, j;
    static uint64_t mask[MAX_SIMPLICES];
    for (s = 0; s < m->mesh.point_count; s++) {
        m->incident[s] = PBW_NONE;
    }
    for (s = count; s-- > 0; ) {
        mask[s] = 0;
        for (i = 0; i < corners; i++) {
            m->incident[m->simplices[s * corners + i]] = (pbw_index)s;
            m->neighbors[s * corners + i] = PBW_NONE;
            mask[s] |= (uint64_t)1 << m->simplices[s * corners + i];
        }
    }
    for (s = 0; s < count; s++) {
        for (i = 0; i < corners; i++) {
            uint64_t facet = mask[s] & ~((uint64_t)1 << m->simplices[s * corners + i]);
            for (t = 0; t < s && m->neighbors[s * corners + i] == PBW_NONE; t++) {
                for (j = 0; j < corners && (mask[t] & facet) == facet; j++) {
                    if (!(facet >> m->simplices[t * corners + j] & 1) && m->neighbors[t * corners + j] == PBW_NONE) {
                        m->neighbors[s * corners + i] = (pbw_index)t;
                        m->neighbors[t * corners + j] = (pbw_index)s;
                    }
                }
            }
        }
    }
}

/* Everything but dim, point_count, points, weights; points whose bit is set in `without` get no simplices. */
static void model_build(model *m, int lowered, uint64_t without)
{
    pbw_index n = (pbw_index)m->mesh.point_count, v[4] = { 0, 0, 0, 0 }, p, q;
    int dim = m->mesh.dim, i;
    m->mesh.simplex_count = m->mesh.duplicate_count = m->mesh.hidden_count = 0;
    for (p = 0; p < n; p++) {
        m->canonical[p] = p;
        for (q = 0; q < n; q++) {
            pbw_index kept = m->canonical[p];
            if (lexicographic(m, p, q) == 0
                && (weight(m, q) > weight(m, kept) || (weight(m, q) == weight(m, kept) && q < kept))) {
                m->canonical[p] = q;
            }
        }
        m->mesh.duplicate_count += m->canonical[p] != p;
    }
    for (;;) {                                       /* all increasing tuples, the last corner running fastest */
        for (i = dim; i >= 0 && v[i] + (pbw_index)(dim - i) >= n; i--) {
            continue;
        }
        if (i < 0) {
            break;
        }
        if (v[dim] == 0) {
            i = -1;                                  /* the first tuple */
        } else {
            v[i]++;
        }
        for (i++; i <= dim; i++) {
            v[i] = i == 0 ? 0 : v[i - 1] + 1;
        }
        if (v[dim] < n && volume(m, v) != 0) {
            pbw_index u[4];
            int fits = 1;
            memcpy(u, v, sizeof u);
            if (volume(m, u) < 0) {
                u[0] = v[1];
                u[1] = v[0];
            }
            for (i = 0; i <= dim; i++) {
                fits = fits && m->canonical[u[i]] == u[i] && !(without >> u[i] & 1);
            }
            for (p = 0; p < n && fits; p++) {
                int corner = 0;
                for (i = 0; i <= dim; i++) {
                    corner |= p == u[i];
                }
                fits = corner || m->canonical[p] != p || (without >> p & 1) || !conflict(m, u, p, lowered);
            }
            if (fits && m->mesh.simplex_count < MAX_SIMPLICES) {
                size_t corners = (size_t)dim + 1;
                memcpy(m->simplices + m->mesh.simplex_count++ * corners, u, corners * sizeof u[0]);
            }
        }
    }
    model_connect(m);
    for (p = 0; p < n && m->mesh.simplex_count > 0; p++) {
        m->mesh.hidden_count += m->canonical[p] == p && m->incident[p] == PBW_NONE;
    }
}

/* n random points of 0..side-1 in each coordinate, weights of 0..heavy-1 unless heavy is 0. */
static void model_random(model *m, int dim, size_t n, uint32_t side, uint32_t heavy)
{
    size_t i;
    memset(m, 0, sizeof *m);
    m->mesh.dim = dim;
    m->mesh.point_count = n;
    model_attach(m, heavy != 0);
    for (i = 0; i < n * (size_t)dim; i++) {
        m->points[i] = input_below(&state, side);
    }
    for (i = 0; i < n; i++) {
        m->weights[i] = heavy != 0 ? input_below(&state, heavy) : 0;
    }
    model_build(m, 0, 0);
}

/* The points of a literal list. */
static void model_points(model *m, int dim, size_t n, const double *points, const double *weights)
{
    memset(m, 0, sizeof *m);
    m->mesh.dim = dim;
    m->mesh.point_count = n;
    model_attach(m, weights != NULL);
    memcpy(m->points, points, n * (size_t)dim * sizeof *points);
    if (weights != NULL) {
        memcpy(m->weights, weights, n * sizeof *weights);
    }
    model_build(m, 0, 0);
}

static size_t entries_of(const model *m)
{
    return m->mesh.simplex_count * (size_t)(m->mesh.dim + 1);
}

static int same_simplices(const model *a, const model *b)                    /* both from model_build */
{
    return a->mesh.simplex_count == b->mesh.simplex_count
        && memcmp(a->simplices, b->simplices, entries_of(a) * sizeof(pbw_index)) == 0
        && memcmp(a->canonical, b->canonical, a->mesh.point_count * sizeof(pbw_index)) == 0;
}

/* Simplices in random order, corners in random even permutations. */
static void model_shuffle(model *m)
{
    size_t corners = (size_t)m->mesh.dim + 1, s;
    for (s = m->mesh.simplex_count; s-- > 0; ) {
        pbw_index other[4], *v = m->simplices + s * corners;
        pbw_index *u = m->simplices + input_below(&state, (uint32_t)s + 1) * corners;
        uint32_t turns = input_below(&state, 3), first = input_below(&state, (uint32_t)corners - 2);
        memcpy(other, u, corners * sizeof *u);
        memcpy(u, v, corners * sizeof *u);
        memcpy(v, other, corners * sizeof *u);
        for (; turns > 0; turns--) {
            pbw_index last = v[first + 2];
            v[first + 2] = v[first + 1];
            v[first + 1] = v[first];
            v[first] = last;
        }
    }
    model_connect(m);
}

/* ---- verdicts ---- */

static const char *verdict(const model *m, pbw_report *report)
{
    CHECK_EQUAL(pbw_check(&m->mesh, NULL, report), PBW_OK);
    CHECK(report->valid == (report->what[0] == '\0'));
    return report->what;
}

static int is_valid(const model *m)
{
    pbw_report report;
    return verdict(m, &report)[0] == '\0';
}

static void expect_at(const model *m, const char *what, int line)
{
    pbw_report report;
    if (!test_check(strcmp(verdict(m, &report), what) == 0, __FILE__, line, what)) {
        test_say("found instead: \"%s\", simplex %d, facet %d, point %d", report.what, (int)report.simplex,
                 (int)report.facet, (int)report.point);
    }
}

#define EXPECT(m, what) expect_at(m, what, __LINE__)

static const char *const corner_range = "a corner is no point";
static const char *const flat = "a simplex is flat";
static const char *const negative = "a simplex is negatively oriented";
static const char *const overlap = "two simplices overlap, the first of the mesh and this";
static const char *const inward = "a hull facet faces inward";
static const char *const concave = "the hull is not convex";
static const char *const no_other = "a neighbor is no other simplex";
static const char *const not_once = "a neighbor does not name the simplex once";
static const char *const not_shared = "neighbors do not share the facet from opposite sides";
static const char *const in_conflict = "the corner across a facet is in conflict";
static const char *const not_first = "the incident simplex of a corner is not the first that has it";
static const char *const incident_lacks = "the incident simplex of a vertex does not have it";
static const char *const outside = "a point outside the hull is no vertex";
static const char *const not_hidden = "a point that is no vertex is not hidden";
static const char *const at_vertex = "a point at a vertex is no duplicate of it";
static const char *const one_place = "two points at one place are no duplicates";
static const char *const other_place = "a duplicate is not where its canonical point is";
static const char *const better = "a duplicate has the better right to be canonical";
static const char *const is_vertex = "a duplicate is a vertex";
static const char *const no_canonical = "the canonical point is none";
static const char *const not_finite = "a coordinate or weight is not finite";
static const char *const spans = "the points span a simplex but there is none";
static const char *const duplicate_count = "duplicate_count is wrong";
static const char *const hidden_count = "hidden_count is wrong";

/* ---- random models ---- */

static void test_random(int dim, int weighted)
{
    long round;
    model m, other;
    if (!test_begin("enumerated %dD %s", dim, weighted ? "weighted" : "unweighted")) {
        return;
    }
    for (round = 0; round < test_count; round++) {
        size_t n = input_below(&state, dim == 2 ? 14 : 11);
        uint32_t side = 2 + input_below(&state, round % 2 == 0 ? 3 : 20);
        model_random(&m, dim, n, side, weighted ? 1 + input_below(&state, side * side) : 0);
        EXPECT(&m, "");
        model_copy(&other, &m);
        model_shuffle(&other);
        EXPECT(&other, "");
        model_copy(&other, &m);
        model_build(&other, 1, 0);
        CHECK_EQUAL(is_valid(&other), same_simplices(&other, &m));
    }
    test_end();
}

/* Is p a free number, which a mesh without simplices may have, as in a view of a live triangulation? */
static int is_free_number(const model *m, size_t p)
{
    size_t i, named = 0;
    for (i = 0; i < m->mesh.point_count; i++) {
        named += m->canonical[i] == p;
    }
    return m->mesh.simplex_count == 0 && m->canonical[p] == PBW_NONE && named == 0;
}

/* Every entry of every index array, changed to every value that is none of its own. */
static void corrupt_all(const model *valid, pbw_index *entry, size_t count, pbw_index values, model *m)
{
    size_t i;
    pbw_index value;
    for (i = 0; i < count; i++) {
        pbw_index kept = entry[i];
        for (value = 0; value < values + 3; value++) {
            int freed;
            entry[i] = value < values ? value : value == values ? 0x80000000u : PBW_NONE - (values + 2 - value);
            freed = entry == m->canonical && kept == i && is_free_number(m, i);
            if (entry[i] != kept && !CHECK(is_valid(m) == freed)) {
                test_say("entry %d: %d for %d, %d simplices", (int)i, (int)entry[i], (int)kept,
                         (int)valid->mesh.simplex_count);
            }
        }
        entry[i] = kept;
    }
}

static void test_corruption(int dim, int weighted)
{
    long round;
    model valid, m;
    if (!test_begin("corrupted %dD %s", dim, weighted ? "weighted" : "unweighted")) {
        return;
    }
    for (round = 0; round < 1 + test_count / 100; round++) {
        size_t n = 5 + input_below(&state, 6), entries, i;
        uint32_t side = round % 2 == 0 ? 3 : 12;
        pbw_index values;
        model_random(&valid, dim, n, side, weighted ? side * side : 0);
        model_copy(&m, &valid);
        entries = m.mesh.simplex_count * (size_t)(dim + 1);
        values = (pbw_index)(m.mesh.simplex_count > n ? m.mesh.simplex_count : n) + 1;
        corrupt_all(&valid, m.simplices, entries, values, &m);
        corrupt_all(&valid, m.neighbors, entries, values, &m);
        corrupt_all(&valid, m.incident, n, values, &m);
        corrupt_all(&valid, m.canonical, n, values, &m);
        for (i = 0; i < n * (size_t)dim + (weighted ? n : 0); i++) {         /* and numbers, which may stay valid */
            double *x = i < n * (size_t)dim ? m.points + i : m.weights + (i - n * (size_t)dim), kept = *x;
            int k;
            for (k = 0; k < 12; k++) {
                model truth;
                *x = (double)input_below(&state, 2 * side) - (double)(side / 2);
                model_copy(&truth, &m);
                model_build(&truth, 0, 0);
                CHECK_EQUAL(is_valid(&m), same_simplices(&truth, &m));
            }
            *x = kept;
        }
        EXPECT(&m, "");
    }
    test_end();
}

/* ---- faults by name ---- */

static size_t find_neighbor_facet(const model *m, size_t from)               /* the next entry that has a neighbour */
{
    while (from < entries_of(m) && m->neighbors[from] == PBW_NONE) {
        from++;
    }
    return from;
}

static void remove_simplex(model *m, size_t s)
{
    size_t corners = (size_t)m->mesh.dim + 1, count = --m->mesh.simplex_count;
    memmove(m->simplices + s * corners, m->simplices + (s + 1) * corners, (count - s) * corners * sizeof(pbw_index));
    model_connect(m);
}

/* All copies of all simplices once more, linked among themselves. */
static void double_cover(model *m)
{
    size_t entries = m->mesh.simplex_count * (size_t)(m->mesh.dim + 1), i;
    for (i = 0; i < entries; i++) {
        m->simplices[entries + i] = m->simplices[i];
        m->neighbors[entries + i] = m->neighbors[i] == PBW_NONE ? PBW_NONE
                                  : m->neighbors[i] + (pbw_index)m->mesh.simplex_count;
    }
    m->mesh.simplex_count *= 2;
}

/* The two simplices at a facet become dim: a flip of an edge, or from 2 to 3.  0 if they do not fit: not convex. */
static int flip(model *m, size_t entry)
{
    size_t corners = (size_t)m->mesh.dim + 1, s = entry / corners, t = m->neighbors[entry], j = 0, k, made = 0;
    pbw_index v[4] = { 0, 0, 0, 0 }, part[3][4], far;
    memcpy(v, m->simplices + s * corners, corners * sizeof *v);
    while (m->neighbors[t * corners + j] != s) {
        j++;
    }
    far = m->simplices[t * corners + j];
    for (k = 0; k < corners; k++) {                  /* both far corners, and the facet without one of its own */
        if (k != entry % corners) {
            memcpy(part[made], v, sizeof v);
            part[made][k] = far;
            if (volume(m, part[made++]) <= 0) {
                return 0;
            }
        }
    }
    memcpy(m->simplices + s * corners, part[0], corners * sizeof *v);
    memcpy(m->simplices + t * corners, part[1], corners * sizeof *v);
    if (made == 3) {
        memcpy(m->simplices + m->mesh.simplex_count++ * corners, part[2], corners * sizeof *v);
    }
    model_connect(m);
    return 1;
}

static void test_links(int dim)
{
    model valid, m;
    size_t corners = (size_t)dim + 1, e, i, s, t;
    model_random(&valid, dim, 10, 30, 0);
    if (!test_begin("wrong links %dD", dim)) {
        return;
    }
    for (e = find_neighbor_facet(&valid, 0); e < entries_of(&valid); e = find_neighbor_facet(&valid, e + 1)) {
        s = e / corners;
        t = valid.neighbors[e];
        model_copy(&m, &valid);
        m.neighbors[e] = (pbw_index)s;
        EXPECT(&m, t < s ? not_once : no_other);
        m.neighbors[e] = (pbw_index)m.mesh.simplex_count;
        EXPECT(&m, t < s ? not_once : no_other);
        m.neighbors[e] = PBW_NONE;                   /* a slit seen from one side, then from both */
        CHECK(!is_valid(&m));
        for (i = 0; m.neighbors[t * corners + i] != s; i++) {
            continue;
        }
        m.neighbors[t * corners + i] = PBW_NONE;
        EXPECT(&m, inward);
        model_copy(&m, &valid);
        for (i = 0; i < corners; i++) {              /* two links of a simplex exchanged */
            if (i != e % corners && m.neighbors[s * corners + i] != PBW_NONE) {
                m.neighbors[e] = m.neighbors[s * corners + i];
                m.neighbors[s * corners + i] = (pbw_index)t;
                EXPECT(&m, not_shared);
                break;
            }
        }
        for (i = 0; i < m.mesh.simplex_count; i++) { /* a stranger */
            model_copy(&m, &valid);
            m.neighbors[e] = (pbw_index)i;
            CHECK(i == t || !is_valid(&m));
        }
    }
    test_end();
}

static void test_simplices(int dim)
{
    model valid, m;
    size_t corners = (size_t)dim + 1, s, i;
    model_random(&valid, dim, 12, 30, 0);
    if (!test_begin("wrong simplices %dD", dim)) {
        return;
    }
    for (s = 0; s < valid.mesh.simplex_count; s++) {
        pbw_index *v = m.simplices + s * corners, *n = m.neighbors + s * corners, kept;
        int interior = 1, first = 0;
        model_copy(&m, &valid);                      /* turned over */
        kept = v[0], v[0] = v[1], v[1] = kept;
        kept = n[0], n[0] = n[1], n[1] = kept;
        EXPECT(&m, negative);
        for (i = 0; i < corners; i++) {
            interior &= n[i] != PBW_NONE;
            first |= m.incident[v[i]] == s;
        }
        if (!first) {
            model_copy(&m, &valid);                  /* a corner twice */
            v[0] = v[1];
            EXPECT(&m, flat);
        }
        model_copy(&m, &valid);
        v[dim] = PBW_NONE;
        CHECK(!is_valid(&m));
        v[dim] = (pbw_index)m.mesh.point_count;
        EXPECT(&m, m.incident[valid.simplices[s * corners + (size_t)dim]] == s ? incident_lacks : corner_range);
        if (!first && interior) {
            model_copy(&m, &valid);                  /* a hole */
            remove_simplex(&m, s);
            EXPECT(&m, inward);
        } else {
            model_copy(&m, &valid);                  /* a notch, or a vertex lost */
            remove_simplex(&m, s);
            CHECK(!is_valid(&m));
        }
        model_copy(&m, &valid);                      /* twice: linked as the original, and on its own */
        memcpy(m.simplices + m.mesh.simplex_count * corners, valid.simplices + s * corners, corners * sizeof *v);
        memcpy(m.neighbors + m.mesh.simplex_count * corners, valid.neighbors + s * corners, corners * sizeof *v);
        m.mesh.simplex_count++;
        EXPECT(&m, s == 0 ? overlap : not_once);
        for (i = 0; i < corners; i++) {
            m.neighbors[(m.mesh.simplex_count - 1) * corners + i] = PBW_NONE;
        }
        EXPECT(&m, s == 0 ? overlap : inward);
    }
    test_end();
}

static void test_flips(int dim, int weighted)
{
    long round;
    int flips = 0;
    model valid, m;
    if (!test_begin("flips %dD %s", dim, weighted ? "weighted" : "unweighted")) {
        return;
    }
    for (round = 0; round < 20; round++) {
        size_t e;
        model_random(&valid, dim, 11, round % 2 == 0 ? 40 : 4, weighted ? 10 : 0);
        for (e = find_neighbor_facet(&valid, 0); e < entries_of(&valid); e = find_neighbor_facet(&valid, e + 1)) {
            model_copy(&m, &valid);
            if (flip(&m, e)) {
                EXPECT(&m, in_conflict);
                flips++;
            }
        }
    }
    CHECK(flips > 100);
    test_end();
}

/* The square and the cube, and pieces of lattices, under another rule of ties. */
static void test_ties(int dim)
{
    long round;
    int differ = 0;
    model valid, m;
    static const double cube[] = { 0,0,0, 1,0,0, 0,1,0, 1,1,0, 0,0,1, 1,0,1, 0,1,1, 1,1,1 };
    static const double square[] = { 0,0, 1,0, 0,1, 1,1 };
    if (!test_begin("ties the other way %dD", dim)) {
        return;
    }
    model_points(&m, dim, dim == 2 ? 4 : 8, dim == 2 ? square : cube, NULL);
    EXPECT(&m, "");
    if (dim == 2) {
        CHECK(flip(&m, find_neighbor_facet(&m, 0)));
        EXPECT(&m, in_conflict);
    }
    for (round = 0; round < 100; round++) {
        model_random(&valid, dim, 10, 3, 0);
        model_copy(&m, &valid);
        model_build(&m, 1, 0);
        if (!same_simplices(&m, &valid)) {
            EXPECT(&m, in_conflict);
            differ++;
        }
    }
    CHECK(differ > 10);
    test_end();
}

/* Two whole meshes; and the same with the links across one facet led to the other mesh, so that a turn about the
   ridges of that facet comes home after two rounds: all is right but the cover. */
static void test_cover(int dim)
{
    model valid, m;
    size_t corners = (size_t)dim + 1, simplices, e, j;
    if (!test_begin("covers %dD", dim)) {
        return;
    }
    model_random(&valid, dim, 9, 20, 0);
    simplices = valid.mesh.simplex_count;
    for (e = find_neighbor_facet(&valid, 0); e < entries_of(&valid); e = find_neighbor_facet(&valid, e + 1)) {
        size_t t = valid.neighbors[e];
        for (j = t * corners; valid.neighbors[j] != e / corners; j++) {
            continue;
        }
        model_copy(&m, &valid);
        double_cover(&m);
        EXPECT(&m, overlap);
        m.neighbors[e] += (pbw_index)simplices;
        m.neighbors[j] += (pbw_index)simplices;
        m.neighbors[simplices * corners + e] -= (pbw_index)simplices;
        m.neighbors[simplices * corners + j] -= (pbw_index)simplices;
        EXPECT(&m, overlap);
    }
    if (dim == 2) {                                  /* two triangles on one side of their common edge */
        static const double fold[] = { 1,3, 0,0, 4,0, 3,2 };
        static const pbw_index triangles[] = { 0,1,2, 3,1,2 };
        model_points(&m, 2, 4, fold, NULL);
        memcpy(m.simplices, triangles, sizeof triangles);
        m.mesh.simplex_count = 2;
        model_connect(&m);
        EXPECT(&m, not_shared);
    }
    test_end();
}

/* Hulls that are closed, consistent and wrong. */
static void test_hull(int dim)
{
    model m;
    if (!test_begin("hulls %dD", dim)) {
        return;
    }
    if (dim == 2) {
        static const double dent[] = { -9,0, 9,0, 0,1, 0,-9 };               /* 2 is near the edge 0 1, 3 across it */
        static const double strip[] = { 0,0, 4,0, 0,3, 4,3, 0,6, 4,6 };
        size_t s;
        model_points(&m, 2, 4, dent, NULL);
        for (s = 0; s < m.mesh.simplex_count; s++) {
            const pbw_index *v = m.simplices + 3 * s;
            CHECK(v[0] + v[1] + v[2] != 3 || m.mesh.simplex_count == 2);
        }
        m.points[5] = -1;                            /* 2 moves inside, its triangle with 0 and 1 is taken away */
        model_build(&m, 0, 0);
        CHECK_EQUAL(m.mesh.simplex_count, 3);
        for (s = 0; s < 3; s++) {
            const pbw_index *v = m.simplices + 3 * s;
            if (v[0] != 3 && v[1] != 3 && v[2] != 3) {
                remove_simplex(&m, s);
                break;
            }
        }
        do {                                         /* the point o of the check near vertex 3, which sees all */
            model_shuffle(&m);
        } while (m.simplices[0] != 3);
        EXPECT(&m, concave);
        model_points(&m, 2, 6, strip, NULL);         /* two rectangles side by side, but not joined */
        for (s = 0; s < m.mesh.simplex_count; s++) {
            size_t i, k;
            for (i = 0; i < 3; i++) {
                int on = 0;
                for (k = 0; k < 3; k++) {
                    on += k != i && (m.simplices[3 * s + k] == 2 || m.simplices[3 * s + k] == 3);
                }
                m.neighbors[3 * s + i] = on == 2 ? PBW_NONE : m.neighbors[3 * s + i];
            }
        }
        EXPECT(&m, inward);
    } else {
        static const double cap[] = { 0,0,0, 10,0,0, 0,10,0, 3,3,2, 3,3,-10 };      /* 3 above 0 1 2, then below it */
        static const double prism[] = { 0,0,0, 5,0,0, 0,5,0, 1,1,6, 1,1,-7 };
        size_t s;
        model_points(&m, 3, 5, cap, NULL);
        EXPECT(&m, "");
        m.points[11] = -2;
        model_build(&m, 0, 0);
        CHECK_EQUAL(m.mesh.simplex_count, 4);
        for (s = 0; s < 4; s++) {
            const pbw_index *v = m.simplices + 4 * s;
            if (v[0] != 4 && v[1] != 4 && v[2] != 4 && v[3] != 4) {
                remove_simplex(&m, s);
                break;
            }
        }
        do {
            model_shuffle(&m);
        } while (m.simplices[0] != 4);
        EXPECT(&m, concave);
        model_points(&m, 3, 5, prism, NULL);         /* two tetrahedra with a common facet, but not joined */
        CHECK_EQUAL(m.mesh.simplex_count, 2);
        for (s = 0; s < 8; s++) {
            m.neighbors[s] = PBW_NONE;
        }
        EXPECT(&m, inward);
    }
    test_end();
}

/* A vertex left out and called hidden; a hidden point forced in. */
static void test_hidden(int dim)
{
    long round;
    int seen_outside = 0, seen_inside = 0, forced = 0;
    model valid, m;
    if (!test_begin("hidden points %dD", dim)) {
        return;
    }
    for (round = 0; round < 120; round++) {
        pbw_index p;
        model_random(&valid, dim, 10, 9, round % 2 == 0 ? 0 : 40);
        for (p = 0; p < valid.mesh.point_count; p++) {
            if (valid.incident[p] != PBW_NONE) {
                pbw_report report;
                const char *what;
                model_copy(&m, &valid);
                model_build(&m, 0, (uint64_t)1 << p);
                if (m.mesh.simplex_count > 0) {      /* other points may cease to be hidden: still one is missing */
                    what = verdict(&m, &report);
                    CHECK(strcmp(what, outside) == 0 || strcmp(what, not_hidden) == 0);
                    seen_outside += strcmp(what, outside) == 0;
                    seen_inside += strcmp(what, not_hidden) == 0;
                }
            } else if (valid.canonical[p] == p && valid.mesh.simplex_count > 0) {
                size_t corners = (size_t)dim + 1, s, i;
                for (s = 0; s < valid.mesh.simplex_count; s++) {             /* split the one that holds it */
                    pbw_index part[4][4] = { { 0 } };
                    int inside = 1;
                    for (i = 0; i < corners; i++) {
                        memcpy(part[i], valid.simplices + s * corners, corners * sizeof(pbw_index));
                        part[i][i] = p;
                        inside = inside && volume(&valid, part[i]) > 0;
                    }
                    if (inside) {
                        model_copy(&m, &valid);
                        for (i = 0; i < corners; i++) {
                            memcpy(m.simplices + (i == 0 ? s : m.mesh.simplex_count++) * corners, part[i],
                                   corners * sizeof(pbw_index));
                        }
                        model_connect(&m);
                        m.mesh.hidden_count--;
                        EXPECT(&m, in_conflict);
                        forced++;
                    }
                }
            }
        }
    }
    if (!CHECK(seen_outside > 10 && seen_inside > 10 && forced > 10)) {
        test_say("%d outside, %d inside, %d forced", seen_outside, seen_inside, forced);
    }
    test_end();
}

static void test_points(void)
{
    static const double square[] = { 0,0, 4,0, 0,4, 4,4, 0,0, 2,1, 0,0, 2,1 };
    static const double weights[] = { 1, 1, 1, 1, 1, -90, 0, -90 };
    model valid, m;
    size_t i;
    if (!test_begin("points by name")) {
        return;
    }
    model_points(&valid, 2, 8, square, weights);     /* 0 4 6 at one place, 5 7 at another and hidden */
    EXPECT(&valid, "");
    CHECK_EQUAL(valid.mesh.duplicate_count, 3);
    CHECK_EQUAL(valid.mesh.hidden_count, 1);

    model_copy(&m, &valid);
    m.canonical[1] = 2;
    EXPECT(&m, other_place);
    m.canonical[1] = 8;
    EXPECT(&m, no_canonical);
    m.canonical[1] = PBW_NONE;
    EXPECT(&m, no_canonical);
    model_copy(&m, &valid);
    m.canonical[6] = 4;                              /* itself a duplicate */
    EXPECT(&m, no_canonical);
    model_copy(&m, &valid);
    m.canonical[0] = m.canonical[4] = m.canonical[6] = 4;                    /* of equal weight, but later */
    EXPECT(&m, better);
    m.canonical[0] = m.canonical[4] = m.canonical[6] = 6;                    /* lighter */
    EXPECT(&m, better);
    model_copy(&m, &valid);
    m.incident[4] = m.incident[0];
    EXPECT(&m, is_vertex);
    model_copy(&m, &valid);
    m.canonical[4] = 4;                              /* alone at the place of a vertex */
    EXPECT(&m, duplicate_count);
    m.mesh.duplicate_count--;
    EXPECT(&m, hidden_count);
    m.mesh.hidden_count++;
    EXPECT(&m, at_vertex);
    model_copy(&m, &valid);
    m.canonical[7] = 7;                              /* both hidden */
    m.mesh.duplicate_count--;
    m.mesh.hidden_count++;
    EXPECT(&m, one_place);
    model_copy(&m, &valid);
    m.mesh.duplicate_count++;
    EXPECT(&m, duplicate_count);
    m.mesh.duplicate_count -= 2;
    EXPECT(&m, duplicate_count);
    model_copy(&m, &valid);
    m.mesh.hidden_count++;
    EXPECT(&m, hidden_count);
    m.mesh.hidden_count -= 2;
    EXPECT(&m, hidden_count);

    model_copy(&m, &valid);
    m.incident[0] = 99;
    EXPECT(&m, incident_lacks);
    for (i = 0; i < 2; i++) {                        /* the last of two simplices, for a point that both have */
        const pbw_index *last = m.simplices + 3;
        model_copy(&m, &valid);
        if (m.incident[1 + i] == 0 && (last[0] == 1 + i || last[1] == 1 + i || last[2] == 1 + i)) {
            m.incident[1 + i] = 1;
            EXPECT(&m, not_first);
        }
    }
    model_copy(&m, &valid);
    m.incident[0] = PBW_NONE;
    m.mesh.hidden_count++;
    EXPECT(&m, not_first);

    for (i = 0; i < 8; i++) {
        volatile double zero = 0.0;
        model_copy(&m, &valid);
        m.points[2 * i + 1] = 1 / zero;
        EXPECT(&m, not_finite);
        m.points[2 * i + 1] = zero / zero;
        EXPECT(&m, not_finite);
        model_copy(&m, &valid);
        m.weights[i] = -1 / zero;
        EXPECT(&m, not_finite);
    }
    model_copy(&m, &valid);
    m.points[0] = m.points[9] = m.points[13] = -0.0;
    EXPECT(&m, "");
    test_end();
}

static void test_degenerate(int dim)
{
    static const double line[] = { 0,0,0, 2,4,6, 1,2,3, 5,10,15, 1,2,3, -3,-6,-9 };
    static const double plane[] = { 0,0,1, 4,0,1, 0,0,1, 0,4,1, 4,4,1, 8,0,1 };
    model m;
    size_t i, n;
    if (!test_begin("degenerate %dD", dim)) {
        return;
    }
    for (n = 0; n <= 6; n++) {
        double points[18];
        for (i = 0; i < 6; i++) {
            memcpy(points + i * (size_t)dim, line + 3 * i, (size_t)dim * sizeof(double));
        }
        model_points(&m, dim, n, points, NULL);
        CHECK_EQUAL(m.mesh.simplex_count, 0);
        EXPECT(&m, "");
        if (n >= 5) {                                /* 2 and 4 are at one place */
            CHECK_EQUAL(m.mesh.duplicate_count, 1);
            m.canonical[4] = 4;
            EXPECT(&m, duplicate_count);
            m.mesh.duplicate_count = 0;
            EXPECT(&m, one_place);
            m.canonical[4] = 2;
            m.mesh.duplicate_count = 1;
        }
        if (n >= 1) {
            m.incident[0] = 0;
            EXPECT(&m, incident_lacks);
            m.incident[0] = PBW_NONE;
            m.mesh.hidden_count = n;
            EXPECT(&m, hidden_count);
        }
    }
    if (dim == 3) {
        model_points(&m, 3, 6, plane, NULL);
        EXPECT(&m, "");
        m.points[17] = 2;
        EXPECT(&m, spans);
    }
    model_random(&m, dim, 12, 9, 0);                 /* simplices withheld */
    CHECK(m.mesh.simplex_count > 0);
    m.mesh.simplex_count = 0;
    for (i = 0; i < 12; i++) {
        m.incident[i] = PBW_NONE;
    }
    EXPECT(&m, spans);
    test_end();
}

/* ---- the call ---- */

static void test_arguments(void)
{
    model m;
    pbw_options options;
    pbw_mesh mesh;
    pbw_report report;
    if (!test_begin("arguments")) {
        return;
    }
    model_random(&m, 3, 8, 9, 5);
    CHECK_EQUAL(pbw_check(NULL, NULL, &report), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_check(&m.mesh, NULL, NULL), PBW_ERROR_ARGUMENT);
    mesh = m.mesh, mesh.points = NULL;
    CHECK_EQUAL(pbw_check(&mesh, NULL, &report), PBW_ERROR_ARGUMENT);
    mesh = m.mesh, mesh.simplices = NULL;
    CHECK_EQUAL(pbw_check(&mesh, NULL, &report), PBW_ERROR_ARGUMENT);
    mesh = m.mesh, mesh.neighbors = NULL;
    CHECK_EQUAL(pbw_check(&mesh, NULL, &report), PBW_ERROR_ARGUMENT);
    mesh = m.mesh, mesh.incident = NULL;
    CHECK_EQUAL(pbw_check(&mesh, NULL, &report), PBW_ERROR_ARGUMENT);
    mesh = m.mesh, mesh.canonical = NULL;
    CHECK_EQUAL(pbw_check(&mesh, NULL, &report), PBW_ERROR_ARGUMENT);
    mesh = m.mesh, mesh.dim = 4;
    CHECK_EQUAL(pbw_check(&mesh, NULL, &report), PBW_ERROR_ARGUMENT);
    memset(&options, 0, sizeof options);
    for (options.threads = -1; options.threads <= 257; options.threads += 258) {
        CHECK_EQUAL(pbw_check(&m.mesh, &options, &report), PBW_ERROR_ARGUMENT);
    }
    memset(&mesh, 0, sizeof mesh);
    CHECK_EQUAL(pbw_check(&mesh, NULL, &report), PBW_ERROR_ARGUMENT);
    CHECK(report.valid == 0 && report.what != NULL && report.simplex == PBW_NONE);
    mesh.dim = 2;                                    /* no points: fine */
    CHECK_EQUAL(pbw_check(&mesh, NULL, &report), PBW_OK);
    CHECK(report.valid == 1);
    test_end();
}

static void test_counts(void)
{
    static const double cube[] = { 0,0,0, 1,0,0, 0,1,0, 1,1,0, 0,0,1, 1,0,1, 0,1,1, 1,1,1 };
    pbw_report report;
    model m;
    if (!test_begin("counts")) {
        return;
    }
    model_points(&m, 3, 8, cube, NULL);
    EXPECT(&m, "");
    verdict(&m, &report);
    CHECK_EQUAL(report.vertex_count, 8);
    CHECK_EQUAL(report.hull_facet_count, 12);
    CHECK_EQUAL(2 * report.facet_count, 4 * m.mesh.simplex_count + 12);
    model_random(&m, 2, 14, 100, 0);
    verdict(&m, &report);
    CHECK_EQUAL(report.vertex_count + m.mesh.simplex_count, report.facet_count + 1);     /* Euler */
    test_end();
}

static void test_resources(void)
{
    model m;
    meter blocks;
    watch w;
    pbw_options options;
    pbw_report report;
    long requests, reports, k;
    if (!test_begin("memory and progress")) {
        return;
    }
    memset(&options, 0, sizeof options);
    options.resize = meter_resize;
    options.resize_user = &blocks;
    options.progress = watch_progress;
    options.progress_user = &w;
    do {
        model_random(&m, 3, 12, 9, 80);
    } while (m.mesh.hidden_count == 0);
    meter_start(&blocks, 0, 0);
    watch_start(&w, 0);
    CHECK_EQUAL(pbw_check(&m.mesh, &options, &report), PBW_OK);
    CHECK(report.valid && blocks.blocks == 0 && blocks.bytes == 0 && blocks.faults == 0);
    CHECK(w.wrong == 0 && w.calls >= 2 && w.stage == PBW_STAGE_CHECK && w.done == 1);
    requests = blocks.requests;
    reports = w.calls;
    for (k = 1; k <= requests; k++) {
        meter_start(&blocks, k, (int)(k & 1));
        watch_start(&w, 0);
        CHECK_EQUAL(pbw_check(&m.mesh, &options, &report), PBW_ERROR_MEMORY);
        CHECK(report.valid == 0 && blocks.refused > 0 && blocks.blocks == 0 && blocks.faults == 0);
    }
    for (k = 1; k <= reports; k++) {
        meter_start(&blocks, 0, 0);
        watch_start(&w, k);
        CHECK_EQUAL(pbw_check(&m.mesh, &options, &report), PBW_CANCELLED);
        CHECK(report.valid == 0 && blocks.blocks == 0 && blocks.faults == 0 && w.calls == k);
    }
    meter_start(&blocks, 0, 0);
    watch_start(&w, 0);
    options.memory_limit = 64;
    CHECK_EQUAL(pbw_check(&m.mesh, &options, &report), PBW_ERROR_MEMORY);
    CHECK(blocks.blocks == 0 && blocks.faults == 0);
    test_end();
}

static void test_modes(void)
{
    static const int modes[] = { FE_TONEAREST, FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO };
    model m;
    pbw_report report;
    uint64_t hash;
    int k;
    if (!test_begin("floating-point modes")) {
        return;
    }
    model_random(&m, 3, 12, 3, 0);
    m.points[1] = m.points[1] == 0.0 ? -0.0 : m.points[1];
    for (k = 0; k < 36; k++) {
        m.points[k] *= 4.9406564584124654e-324;      /* denormal: to flush them would make all equal */
    }
    hash = pbw_hash(&m.mesh, NULL);
    for (k = 0; k < 4; k++) {
        pbw_status status;
        fesetround(modes[k]);
        status = pbw_check(&m.mesh, NULL, &report);
        CHECK(fegetround() == modes[k] && pbw_hash(&m.mesh, NULL) == hash);
        fesetround(FE_TONEAREST);
        CHECK(status == PBW_OK && report.valid);
    }
#ifdef __SSE2__
    {
        unsigned kept = _mm_getcsr(), flushing;
        _mm_setcsr(kept | 0x8040u);                  /* flush denormals, results and operands */
        flushing = _mm_getcsr() & 0x8040u;           /* valgrind has no such mode */
        CHECK(pbw_check(&m.mesh, NULL, &report) == PBW_OK && report.valid && pbw_hash(&m.mesh, NULL) == hash);
        CHECK((_mm_getcsr() & 0x8040u) == flushing);
        _mm_setcsr(kept);
    }
#endif
    test_end();
}

/* ---- with the library's own triangulations ---- */

/* Random entries of the index arrays, changed and put back. */
static void corrupt_some(pbw_mesh *mesh)
{
    size_t entries = mesh->simplex_count * (size_t)(mesh->dim + 1), i;
    int round;
    for (round = 0; round < 8; round++) {
        const pbw_index *const array = round % 4 == 0 ? mesh->simplices : round % 4 == 1 ? mesh->neighbors
                                     : round % 4 == 2 ? mesh->incident : mesh->canonical;
        pbw_index *entry = (pbw_index *)(uintptr_t)array, kept;
        pbw_report report;
        i = (size_t)(input_next(&state) % (round % 4 < 2 ? entries : mesh->point_count));
        kept = entry[i];
        entry[i] = round < 4 ? kept ^ 1u : input_below(&state, (uint32_t)entries);
        CHECK_EQUAL(pbw_check(mesh, NULL, &report), PBW_OK);
        CHECK(report.valid == (entry[i] == kept));
        entry[i] = kept;
    }
}

static void triangulated(int dim, int kind, int weights_kind, size_t n, unsigned flags)
{
    double *points = (double *)malloc(n * (size_t)dim * sizeof *points);
    double *weights = (double *)malloc(n * sizeof *weights);
    pbw_options options;
    pbw_report report;
    pbw_mesh mesh;
    pbw_status status;
    memset(&options, 0, sizeof options);
    options.flags = flags;
    input_fill(kind, dim, n, test_seed, points);
    if (weights_kind >= 0) {
        input_fill_weights(weights_kind, dim, n, test_seed, points, weights);
    }
    status = pbw_triangulate(dim, points, weights_kind >= 0 ? weights : NULL, n, &options, &mesh);
    CHECK(status == PBW_OK);
    if (status == PBW_OK) {
        CHECK_EQUAL(pbw_check(&mesh, NULL, &report), PBW_OK);
        if (!CHECK(report.valid)) {
            test_say("%s: \"%s\", simplex %u, facet %u, point %u", input_name(kind), report.what, report.simplex,
                     report.facet, report.point);
        }
        corrupt_some(&mesh);
        pbw_free(&mesh);
    }
    free(points);
    free(weights);
}

static void *triangulated_all(void *argument)
{
    int dim = *(int *)argument, kind;
    for (kind = 0; kind < INPUT_KINDS; kind++) {
        triangulated(dim, kind, -1, kind == INPUT_MOMENT ? 60 : 2000, kind % 2 == 0 ? PBW_ANY_ORDER : 0);
    }
    for (kind = 0; kind < INPUT_WEIGHTS_KINDS; kind++) {
        triangulated(dim, kind % 2 == 0 ? INPUT_UNIFORM : INPUT_LATTICE, kind, 2000, 0);
    }
    return NULL;
}

static void test_triangulated(int dim)
{
    pthread_attr_t attributes;
    pthread_t thread;
    if (!test_begin("triangulated %dD, on a small stack", dim)) {
        return;
    }
    pthread_attr_init(&attributes);
    if (pthread_attr_setstacksize(&attributes, 256 * 1024) != 0
        || pthread_create(&thread, &attributes, triangulated_all, &dim) != 0) {
        test_skip("no thread");
    } else {
        pthread_join(thread, NULL);
        test_end();
    }
    pthread_attr_destroy(&attributes);
}

/* ---- the hash ---- */

static void test_hash(int dim, int weighted)
{
    long round;
    if (!test_begin("hash %dD %s", dim, weighted ? "weighted" : "unweighted")) {
        return;
    }
    for (round = 0; round < test_count; round++) {
        model m, other;
        size_t n = 5 + input_below(&state, 6), i;
        pbw_index rank[MAX_POINTS];
        uint64_t hash;
        model_random(&m, dim, n, round % 2 == 0 ? 3 : 12, weighted ? 9 : 0);
        if (m.mesh.simplex_count == 0) {
            continue;
        }
        hash = pbw_hash(&m.mesh, NULL);
        CHECK(hash != 0);
        model_copy(&other, &m);
        model_shuffle(&other);
        CHECK(pbw_hash(&other.mesh, NULL) == hash);        /* any order of simplices and corners */

        model_copy(&other, &m);                      /* any order of points */
        for (i = 0; i < n; i++) {
            size_t j = input_below(&state, (uint32_t)i + 1);
            rank[i] = rank[j];
            rank[j] = (pbw_index)i;
        }
        for (i = 0; i < n; i++) {
            memcpy(other.points + rank[i] * (size_t)dim, m.points + i * (size_t)dim, (size_t)dim * sizeof(double));
            other.weights[rank[i]] = m.weights[i];
        }
        model_build(&other, 0, 0);
        CHECK(pbw_hash(&other.mesh, NULL) == hash);

        model_copy(&other, &m);                      /* a duplicate more */
        memcpy(other.points + n * (size_t)dim, m.points, (size_t)dim * sizeof(double));
        other.weights[n] = m.weights[0];
        other.mesh.point_count++;
        model_build(&other, 0, 0);
        CHECK(pbw_hash(&other.mesh, NULL) == hash);

        model_copy(&other, &m);                      /* -0.0 for 0.0 */
        for (i = 0; i < n * (size_t)dim; i++) {
            other.points[i] = m.points[i] == 0.0 ? -0.0 : m.points[i];
        }
        CHECK(pbw_hash(&other.mesh, NULL) == hash);

        for (i = find_neighbor_facet(&m, 0); i < entries_of(&m); i = find_neighbor_facet(&m, i + 1)) {
            model_copy(&other, &m);                  /* other simplices */
            if (flip(&other, i)) {
                CHECK(pbw_hash(&other.mesh, NULL) != hash);
            }
        }
        for (i = 0; i < m.mesh.simplex_count; i++) {
            model_copy(&other, &m);
            remove_simplex(&other, i);
            CHECK(pbw_hash(&other.mesh, NULL) != hash);
        }
        for (i = 0; i < n; i++) {                    /* other points or weights with the same simplices */
            if (m.canonical[i] == i) {
                model_copy(&other, &m);
                other.points[i * (size_t)dim] += 1e-9;
                CHECK(pbw_hash(&other.mesh, NULL) != hash);
                if (weighted) {
                    model_copy(&other, &m);
                    other.weights[i] += 1e-9;
                    CHECK(pbw_hash(&other.mesh, NULL) != hash);
                }
            }
        }
        for (i = 0; i < n; i++) {
            m.weights[i] = 0.0;
        }
        m.mesh.weights = NULL;                       /* no weights, all weights zero */
        hash = pbw_hash(&m.mesh, NULL);
        m.mesh.weights = m.weights;
        CHECK(pbw_hash(&m.mesh, NULL) == hash);
    }
    test_end();
}

static void test_hash_special(void)
{
    static const double flat2[] = { 1,2, 3,4 }, flat3[] = { 1,2,0, 3,4,0 };
    static const pbw_index apart[] = { 0,1,2, 3,4,5 }, mixed[] = { 0,1,3, 2,4,5 };
    pbw_mesh none;
    model m;
    uint64_t hash;
    if (!test_begin("hash, special cases")) {
        return;
    }
    memset(&none, 0, sizeof none);
    CHECK(pbw_hash(&none, NULL) == 0);
    CHECK(pbw_hash(NULL, NULL) == 0);
    model_points(&m, 2, 2, flat2, NULL);             /* degenerate: the points count */
    hash = pbw_hash(&m.mesh, NULL);
    CHECK(hash != 0);
    model_points(&m, 3, 2, flat3, NULL);
    CHECK(pbw_hash(&m.mesh, NULL) != hash);
    model_points(&m, 2, 1, flat2, NULL);
    CHECK(pbw_hash(&m.mesh, NULL) != hash);
    model_random(&m, 2, 6, 1000, 0);                 /* the same corners in other company */
    memcpy(m.simplices, apart, sizeof apart);
    m.mesh.simplex_count = 2;
    hash = pbw_hash(&m.mesh, NULL);
    memcpy(m.simplices, mixed, sizeof mixed);
    CHECK(pbw_hash(&m.mesh, NULL) != hash);
    test_end();
}

/* Floats and the same numbers as doubles; no two of many triangulations agree. */
static void test_hash_triangulated(int dim)
{
    enum { COUNT = 300, ROUNDS = 200 };
    static float narrow[3 * COUNT];
    static double wide[3 * COUNT];
    uint64_t seen[ROUNDS];
    size_t i, k;
    if (!test_begin("hash of triangulations %dD", dim)) {
        return;
    }
    for (k = 0; k < ROUNDS; k++) {
        pbw_mesh a, b;
        for (i = 0; i < (size_t)dim * COUNT; i++) {
            narrow[i] = (float)input_uniform(&state) - 0.5f;
            wide[i] = (double)narrow[i];
        }
        CHECK_EQUAL(pbw_triangulatef(dim, narrow, NULL, COUNT, NULL, &a), PBW_OK);
        CHECK_EQUAL(pbw_triangulate(dim, wide, NULL, COUNT, NULL, &b), PBW_OK);
        seen[k] = pbw_hash(&a, NULL);
        CHECK(seen[k] == pbw_hash(&b, NULL));
        for (i = 0; i < k; i++) {
            CHECK(seen[i] != seen[k]);
        }
        pbw_free(&a);
        pbw_free(&b);
    }
    test_end();
}

int main(int argc, char **argv)
{
    int dim, weighted;
    test_start(argc, argv, 300);
    state = test_seed;
    for (dim = 2; dim <= 3; dim++) {
        for (weighted = 0; weighted <= 1; weighted++) {
            test_random(dim, weighted);
            test_corruption(dim, weighted);
            test_flips(dim, weighted);
            test_hash(dim, weighted);
        }
        test_links(dim);
        test_simplices(dim);
        test_ties(dim);
        test_cover(dim);
        test_hull(dim);
        test_hidden(dim);
        test_degenerate(dim);
        test_triangulated(dim);
        test_hash_triangulated(dim);
    }
    test_points();
    test_arguments();
    test_counts();
    test_resources();
    test_modes();
    test_hash_special();
    return test_finish();
}
