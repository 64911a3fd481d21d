/* test_crossings.c: pbw_surface_crossings against a search of all pairs in integers, on many soups of triangles; the
   same for all threads, coordinates of any magnitude, progress, cancelling, and sound after every failure; steps of
   the search in rows of needles; winding numbers by the open edges of surfaces. */
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#include "meter.h"
#include "test.h"
#include "watch.h"
#include "zoo.h"
#include <math.h>

enum { MOST_POINTS = 1500, MOST_TRIANGLES = 500, MOST_PAIRS = 100000 };

typedef long long whole;

typedef struct soup {
    whole x[MOST_POINTS][3];
    double points[3 * MOST_POINTS];
    pbw_index triangles[3 * MOST_TRIANGLES];
    size_t points_count, triangle_count;
} soup;

static soup s;

/* ---- all pairs, in integers: a point is x / x[3] */

static void minus(const whole *p, const whole *q, whole *out)
{
    int k;
    for (k = 0; k < 3; k++) {
        out[k] = p[k] - q[k];
    }
}

static void cross(const whole *a, const whole *b, whole *out)
{
    int k;
    for (k = 0; k < 3; k++) {
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    }
}

static whole dot(const whole *a, const whole *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static int same(const whole *p, const whole *q)
{
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

static const whole *corner(size_t t, int k)
{
    return s.x[s.triangles[3 * t + (size_t)k % 3]];
}

static void normal(size_t t, whole *n)
{
    whole u[3], v[3];
    minus(corner(t, 1), corner(t, 0), u);
    minus(corner(t, 2), corner(t, 0), v);
    cross(u, v, n);
}

static int is_flat(size_t t)
{
    whole n[3];
    normal(t, n);
    return n[0] == 0 && n[1] == 0 && n[2] == 0;
}

static int is_same_triangle(size_t t, size_t u)
{
    int i, j, found = 0;
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3 && !same(corner(t, i), corner(u, j)); j++) {
        }
        found += j < 3;
    }
    return found == 3;
}

static int is_in(const whole p[4], size_t t)
{
    whole n[3], side[3], inward[3], d[3];
    int i, k;
    normal(t, n);
    for (i = 0; i < 3; i++) {
        for (k = 0; k < 3; k++) {
            d[k] = p[k] - p[3] * corner(t, i)[k];
        }
        minus(corner(t, i + 1), corner(t, i), side);
        cross(n, side, inward);
        if (dot(n, d) != 0 || dot(inward, d) < 0) {
            return 0;
        }
    }
    return 1;
}

/* Is p in both triangles, and no corner of both? */
static int is_fault(const whole given[4], size_t t, size_t u)
{
    whole p[4];
    int i, j, k;
    for (k = 0; k < 4; k++) {
        p[k] = given[3] < 0 ? -given[k] : given[k];
    }
    if (!is_in(p, t) || !is_in(p, u)) {
        return 0;
    }
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            for (k = 0; k < 3 && p[k] == p[3] * corner(t, i)[k]; k++) {
            }
            if (k == 3 && same(corner(t, i), corner(u, j))) {
                return 0;
            }
        }
    }
    return 1;
}

/* a + (b - a) num / den. */
static int is_fault_along(const whole *a, const whole *b, whole num, whole den, size_t t, size_t u)
{
    whole p[4];
    int k;
    for (k = 0; k < 3; k++) {
        p[k] = a[k] * (den - num) + b[k] * num;
    }
    p[3] = den;
    return den != 0 && is_fault(p, t, u);
}

/* What two triangles have in common is convex, and its extreme points are corners, points of a side in the other's
   plane, or in one plane where two sides meet: is one of them a fault? */
static int has_fault(size_t t, size_t u)
{
    whole n[3], d[3], e[3], f[3], g[3], along[3];
    int i, j;
    normal(u, n);
    for (i = 0; i < 3; i++) {
        const whole *a = corner(t, i), *b = corner(t, i + 1);
        minus(corner(u, 0), a, d);
        minus(b, a, e);
        if (is_fault_along(a, b, 0, 1, t, u) || is_fault_along(a, b, dot(n, d), dot(n, e), t, u)) {
            return 1;
        }
        for (j = 0; j < 3; j++) {
            minus(corner(u, j + 1), corner(u, j), f);
            minus(corner(u, j), a, d);
            cross(e, f, g);
            cross(d, f, along);
            if (is_fault_along(a, b, dot(along, g), dot(g, g), t, u)) {
                return 1;
            }
        }
    }
    return 0;
}

/* Are their boxes apart? */
static int are_apart(size_t t, size_t u)
{
    int i, j, k;
    for (k = 0; k < 3; k++) {
        int under = 0, over = 0;
        for (i = 0; i < 3; i++) {
            for (j = 0; j < 3; j++) {
                under += corner(t, i)[k] < corner(u, j)[k];
                over += corner(t, i)[k] > corner(u, j)[k];
            }
        }
        if (under == 9 || over == 9) {
            return 1;
        }
    }
    return 0;
}

/* ---- soups */

static uint64_t state;

static whole below(whole n)
{
    return (whole)(pbw_random(test_seed, state++) % (uint64_t)n);
}

/* span: coordinates are below it; welded: triangles have points in common by number. */
static void make_soup(size_t triangles, whole span, int welded)
{
    const whole points = 3 + below(welded ? 12 : 8), plane = below(4), depth = below(3) == 0 ? 1 + below(2) : span;
    size_t i;
    int k;
    s.triangle_count = triangles;
    s.points_count = welded ? (size_t)points : 3 * triangles;
    for (i = 0; i < s.points_count; i++) {
        for (k = 0; k < 3; k++) {
            s.x[i][k] = below(k == plane ? depth : span);
        }
    }
    for (i = 0; i < 3 * triangles; i++) {
        s.triangles[i] = welded ? (pbw_index)below(points) : (pbw_index)i;
    }
}

/* Small triangles all over a large box, some of them with a corner of the one before. */
static void make_large_soup(size_t triangles)
{
    size_t i;
    int k;
    make_soup(triangles, 90, 0);
    for (i = 0; i < 3 * triangles; i++) {
        for (k = 0; k < 3; k++) {
            s.x[i][k] = i % 3 == 0 ? below(90) : s.x[i / 3 * 3][k] + below(10);
        }
        if (i >= 3 && below(3) == 0) {
            s.triangles[i] = s.triangles[i - 3];
        }
    }
}

/* Needles side by side, parallel to no axis, some of which cross. */
static void make_needles(size_t triangles)
{
    size_t i;
    int k;
    make_soup(triangles, 90, 0);
    for (i = 0; i < 3 * triangles; i++) {
        for (k = 0; k < 3; k++) {
            s.x[i][k] = i % 3 == 0 ? below(20) : s.x[i / 3 * 3][k] + (i % 3 == 2) * (75 - 8 * k) + below(3);
        }
    }
}

/* Two apices over a polygon of 3 to 8 corners, which may wind around them once, twice, or not at all; now and then a
   triangle is left out or turned, or there are others in its way. */
static void make_fans(void)
{
    const size_t corners = (size_t)(3 + below(6)), fault = (size_t)below(12 * (whole)corners);
    const whole span = 5 + below(8), times = 1 + below(2), x = below(3), y = (x + 1) % 3, z = (x + 2) % 3;
    size_t i, k;
    make_soup(2 * corners + (size_t)(below(4) == 0), span, 0);
    for (i = 0; i < corners && below(4) > 0; i++) {      /* in turn around the middle */
        const double angle = 6.283185307179586 * (double)times * ((double)i + 0.4) / (double)corners;
        s.x[i][x] = (whole)floor((double)span * (0.5 + 0.5 * cos(angle)) + 0.5);
        s.x[i][y] = (whole)floor((double)span * (0.5 + 0.5 * sin(angle)) + 0.5);
    }
    for (k = 0; k < 2; k++) {
        s.x[corners + k][x] = s.x[corners + k][y] = span / 2;
        s.x[corners + k][z] = k == 0 ? -below(9) : span + below(9);
        for (i = 0; i < corners; i++) {
            pbw_index *t = s.triangles + 3 * (k * corners + i);
            t[0] = (pbw_index)(corners + k);
            t[1 + k] = (pbw_index)i;
            t[2 - k] = (pbw_index)((i + 1) % corners);
        }
    }
    if (fault < 2 * corners) {
        pbw_index *t = s.triangles + 3 * fault;
        const pbw_index swap = t[0];
        t[0] = below(2) == 0 ? t[1] : t[2];
        t[below(2) == 0 ? 1 : 2] = swap;
    }
}

static void set_points(double scale, double shift)
{
    size_t i;
    for (i = 0; i < 3 * s.points_count; i++) {
        s.points[i] = ((double)s.x[i / 3][i % 3] + shift) * scale;
    }
}

static pbw_status find(const pbw_options *options, pbw_surface_faults *f)
{
    return pbw_surface_crossings(s.points, s.points_count, s.triangles, s.triangle_count, options, f);
}

static size_t first_at(size_t point)
{
    size_t i = 0;
    while (!same(s.x[i], s.x[point])) {
        i++;
    }
    return i;
}

/* ---- checks of one answer */

static void check_pairs(const pbw_surface_faults *f)
{
    size_t t, u, k, crossings = 0, duplicates = 0, flat = 0;
    for (t = 0; t < s.triangle_count; t++) {
        size_t first = t;
        if (is_flat(t)) {
            CHECK(flat < f->flat_count && f->flat[flat] == t);
            flat++;
        }
        for (u = 0; u < t && first == t; u++) {
            first = is_same_triangle(t, u) && !same(corner(t, 0), corner(t, 1)) && !same(corner(t, 1), corner(t, 2))
                 && !same(corner(t, 2), corner(t, 0)) ? u : t;
        }
        if (first < t) {
            CHECK(duplicates < f->duplicate_count && f->duplicates[2 * duplicates] == t
                  && f->duplicates[2 * duplicates + 1] == first);
            duplicates++;
        }
        for (u = t + 1; u < s.triangle_count; u++) {
            int again = 0;
            for (k = 0; k < f->duplicate_count; k++) {
                again |= f->duplicates[2 * k] == t || f->duplicates[2 * k] == u;
            }
            if (!again && !are_apart(t, u) && !is_flat(t) && !is_flat(u) && (has_fault(t, u) || has_fault(u, t))) {
                CHECK(crossings < f->crossing_count && f->crossings[2 * crossings] == t
                      && f->crossings[2 * crossings + 1] == u);
                crossings++;
            }
        }
    }
    CHECK_EQUAL(f->crossing_count, crossings);
    CHECK_EQUAL(f->flat_count, flat);
    CHECK_EQUAL(f->duplicate_count, duplicates);
}

static void check_edges(const pbw_surface_faults *f)
{
    size_t i, k, repeated = 0, edges = 0;
    for (i = 0; i < s.points_count; i++) {
        if (first_at(i) != i) {
            CHECK(repeated < f->repeated_count && f->repeated[2 * repeated] == i
                  && f->repeated[2 * repeated + 1] == first_at(i));
            repeated++;
        }
    }
    CHECK_EQUAL(f->repeated_count, repeated);
    for (i = 0; i < f->edge_count; i++) {
        CHECK(f->edges[2 * i] < f->edges[2 * i + 1]);
        CHECK(i == 0 || f->edges[2 * i] > f->edges[2 * i - 2]
              || (f->edges[2 * i] == f->edges[2 * i - 2] && f->edges[2 * i + 1] > f->edges[2 * i - 1]));
    }
    for (i = 0; i < 3 * s.triangle_count; i++) {
        const size_t a = first_at(s.triangles[i]), b = first_at(s.triangles[i / 3 * 3 + (i + 1) % 3]);
        size_t there = 0, back = 0, earlier = 0;
        for (k = 0; k < 3 * s.triangle_count && a != b; k++) {
            const size_t c = first_at(s.triangles[k]), d = first_at(s.triangles[k / 3 * 3 + (k + 1) % 3]);
            there += c == a && d == b;
            back += c == b && d == a;
            earlier += k < i && ((c == a && d == b) || (c == b && d == a));
        }
        if (a == b || earlier > 0 || (there == 1 && back == 1)) {
            continue;
        }
        edges++;
        for (k = 0; k < f->edge_count; k++) {
            const pbw_index *e = f->edges + 2 * k;
            if (e[0] + e[1] == a + b && (e[0] == a || e[0] == b)) {
                break;
            }
        }
        CHECK(k < f->edge_count && f->edge_triangles[k] == there + back);
    }
    CHECK_EQUAL(f->edge_count, edges);
}

/* Are the ends of all segments in both triangles, up to rounding? */
static void check_segments(const pbw_surface_faults *f)
{
    size_t i;
    int k;
    for (i = 0; i < 4 * f->crossing_count; i++) {
        const size_t t = f->crossings[2 * (i / 4) + i % 2];
        const double *p = f->segments + 6 * (i / 4) + 3 * (i / 2 % 2);
        double place[3], d[3];
        pbwsf__nearest_in(s.points + 3 * (size_t)s.triangles[3 * t], s.points + 3 * (size_t)s.triangles[3 * t + 1],
                          s.points + 3 * (size_t)s.triangles[3 * t + 2], p, place);
        for (k = 0; k < 3; k++) {
            d[k] = p[k] - place[k];
        }
        CHECK(pbwsf__dot(d, d) < 1e-16);                 /* 4e-10 in a needle 100 long */
    }
}

static void test_soups(void)
{
    long n;
    size_t crossings = 0;
    pbw_options alone = { 0 };
    alone.threads = 1;
    if (!test_begin("%ld soups, all pairs in integers", test_count)) {
        return;
    }
    for (n = 0; n < test_count; n++) {
        pbw_surface_faults f;
        if (n % 1000 == 7) {
            make_large_soup(n == 7 ? 264 : 120);         /* a tree of three levels of nodes, of two */
        } else if (n % 2000 == 11) {
            make_needles(320);                           /* boxes alone take too many steps */
        } else if (n % 4 == 3) {
            make_fans();
        } else {
            make_soup((size_t)(1 + below(7)), 2 + below(5), n % 3 != 0);
        }
        set_points(1, 0);
        CHECK_EQUAL(find(&alone, &f), PBW_OK);
        check_pairs(&f);
        if (n % 2000 != 11) {                            /* those of needles are alike, and take long */
            check_edges(&f);
        }
        check_segments(&f);
        crossings += f.crossing_count;
        pbw_surface_faults_free(&f);
    }
    CHECK(2 * crossings > (size_t)test_count);
    test_say("%zu pairs that meet", crossings);
    test_end();
}

static int same_ids(const pbw_index *a, const pbw_index *b, size_t count)
{
    return count == 0 || memcmp(a, b, count * sizeof *a) == 0;
}

static int same_faults(const pbw_surface_faults *f, const pbw_surface_faults *g)
{
    return f->crossing_count == g->crossing_count && f->flat_count == g->flat_count
        && f->duplicate_count == g->duplicate_count && f->edge_count == g->edge_count
        && f->repeated_count == g->repeated_count && same_ids(f->crossings, g->crossings, 2 * f->crossing_count)
        && same_ids(f->flat, g->flat, f->flat_count) && same_ids(f->edges, g->edges, 2 * f->edge_count)
        && same_ids(f->duplicates, g->duplicates, 2 * f->duplicate_count)
        && same_ids(f->edge_triangles, g->edge_triangles, f->edge_count)
        && same_ids(f->repeated, g->repeated, 2 * f->repeated_count);
}

/* The same integers as coordinates of all magnitudes: products over- and underflow. */
static void test_magnitudes(void)
{
    static const double scale[] = { 1e-300, 4e-320, 1e-160, 1e-90, 1e80, 1e150, 1e297 };
    size_t k;
    long n;
    if (!test_begin("coordinates of all magnitudes, and far from the origin")) {
        return;
    }
    for (n = 0; n <= 40; n++) {
        pbw_surface_faults one, f;
        make_soup(12, 6, (int)(n % 2));
        if (n == 40) {
            make_needles(320);
        }
        set_points(1, 0);
        CHECK_EQUAL(find(NULL, &one), PBW_OK);
        for (k = 0; k < sizeof scale / sizeof *scale; k++) {
            set_points(ldexp(1, (int)floor(log2(scale[k]))), 0);
            CHECK_EQUAL(find(NULL, &f), PBW_OK);
            CHECK(same_faults(&one, &f));
            pbw_surface_faults_free(&f);
        }
        set_points(1, 4503599627370496.0);
        CHECK_EQUAL(find(NULL, &f), PBW_OK);
        CHECK(same_faults(&one, &f));
        pbw_surface_faults_free(&f);
        pbw_surface_faults_free(&one);
    }
    test_end();
}

/* A corner above a triangle, on it, and just off it. */
static void test_nearly(void)
{
    double points[18] = { 0, 0, 0, 4, 0, 0, 0, 4, 0, 1, 1, 0, 1, 2, 1, 2, 1, 1 };
    const pbw_index triangles[6] = { 0, 1, 2, 3, 4, 5 };
    pbw_surface_faults f;
    if (!test_begin("nearly touching is no fault")) {
        return;
    }
    CHECK(pbw_surface_crossings(points, 6, triangles, 2, NULL, &f) == PBW_OK && f.crossing_count == 1);
    CHECK(f.segments[0] == 1 && f.segments[1] == 1 && f.segments[2] == 0 && f.segments[3] == 1 && f.segments[5] == 0);
    pbw_surface_faults_free(&f);
    points[11] = 5e-324;
    CHECK(pbw_surface_crossings(points, 6, triangles, 2, NULL, &f) == PBW_OK && f.crossing_count == 0);
    pbw_surface_faults_free(&f);
    points[11] = -5e-324;
    CHECK(pbw_surface_crossings(points, 6, triangles, 2, NULL, &f) == PBW_OK && f.crossing_count == 1);
    pbw_surface_faults_free(&f);
    pbw_surface_faults_free(&f);
    test_end();
}

static void test_refusals(void)
{
    const pbw_index triangles[6] = { 0, 1, 2, 1, 2, 3 };
    double points[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    pbw_surface_faults f;
    if (!test_begin("nothing, ids out of range, coordinates that are not finite")) {
        return;
    }
    CHECK(pbw_surface_crossings(NULL, 0, NULL, 0, NULL, &f) == PBW_OK && f.crossing_count == 0 && f.edge_count == 0);
    pbw_surface_faults_free(&f);
    CHECK(pbw_surface_crossings(points, 3, NULL, 0, NULL, &f) == PBW_OK && f.repeated_count == 0);
    pbw_surface_faults_free(&f);
    CHECK(pbw_surface_crossings(points, 3, triangles, 1, NULL, &f) == PBW_OK && f.edge_count == 3);
    pbw_surface_faults_free(&f);
    CHECK_EQUAL(pbw_surface_crossings(points, 3, triangles, 2, NULL, &f), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_surface_crossings(points, 3, triangles, PBW_NONE, NULL, &f), PBW_ERROR_TOO_LARGE);
    CHECK_EQUAL(pbw_surface_crossings(points, 3, triangles, 1, NULL, NULL), PBW_ERROR_ARGUMENT);
    points[4] = NAN;
    CHECK_EQUAL(pbw_surface_crossings(points, 3, triangles, 1, NULL, &f), PBW_ERROR_NOT_FINITE);
    CHECK(f.memory == NULL);
    test_end();
}

/* Queries of surfaces without triangles, places that are none, counts that nothing can have. */
static void test_empty(void)
{
    static const double x[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, none[3] = { 0, NAN, 0 }, far[3] = { 0, 0, HUGE_VAL };
    static const double above[3] = { 0.2, 0.2, 1 }, below[3] = { 0.2, 0.2, -1 }, limits[] = { 0, -5, NAN };
    static const pbw_index ids[3] = { 0, 1, 2 };
    const size_t huge[] = { (size_t)PBW_NONE + 1, (size_t)-1, (size_t)-1 / 3 + 1 };
    pbw_surface tree;
    pbw_surface_faults f;
    double place[3], where;
    size_t i;
    if (!test_begin("empty surfaces, places that are none")) {
        return;
    }
    for (i = 0; i < 3; i++) {                        /* {0}, one without triangles, NaN */
        const double *p = i == 2 ? none : above;
        memset(&tree, 0, sizeof tree);
        CHECK_EQUAL(i == 0 ? PBW_OK : pbw_surface_create(x, 3, ids, i / 2, NULL, &tree), PBW_OK);
        CHECK(pbw_surface_closest(&tree, p, HUGE_VAL, place) == PBW_NONE);
        CHECK(pbw_surface_meets(&tree, p, below, &where) == PBW_NONE);
        CHECK(pbw_surface_meets(&tree, below, p, &where) == PBW_NONE);
        CHECK(pbw_surface_inside(&tree, p) == 0 && pbw_surface_turns(&tree, p) == 0);
        CHECK(!(fabs(pbw_surface_winding(&tree, p)) > 0));
        pbw_surface_free(&tree);
        CHECK(pbw_surface_create(x, huge[i], ids, 1, NULL, &tree) == PBW_ERROR_TOO_LARGE || sizeof(size_t) == 4);
        CHECK(pbw_surface_create(x, 3, ids, huge[i], NULL, &tree) == PBW_ERROR_TOO_LARGE || sizeof(size_t) == 4);
        CHECK(pbw_surface_crossings(x, huge[i], ids, 1, NULL, &f) == PBW_ERROR_TOO_LARGE || sizeof(size_t) == 4);
        CHECK(pbw_surface_crossings(x, 3, ids, huge[i], NULL, &f) == PBW_ERROR_TOO_LARGE || sizeof(size_t) == 4);
    }
    CHECK_EQUAL(pbw_surface_create(x, 3, ids, 1, NULL, &tree), PBW_OK);
    for (i = 0; i < 3; i++) {
        CHECK(pbw_surface_closest(&tree, above, limits[i], place) == PBW_NONE);
    }
    CHECK(pbw_surface_closest(&tree, above, 1.1, place) == 0 && pbw_surface_meets(&tree, above, below, &where) == 0);
    CHECK(pbw_surface_inside(&tree, far) == 0);
    pbw_surface_free(&tree);
    CHECK_EQUAL(pbw_surface_create(NULL, 3, ids, 1, NULL, &tree), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_surface_create(x, 3, NULL, 1, NULL, &tree), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_surface_crossings(NULL, 3, ids, 1, NULL, &f), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_surface_crossings(x, 3, NULL, 1, NULL, &f), PBW_ERROR_ARGUMENT);
    test_end();
}

static void test_threads(void)
{
    pbw_surface_faults one, f;
    pbw_options options = { 0 };
    int needles;
    if (!test_begin("the same for 1 to 7 threads, progress")) {
        return;
    }
    for (needles = 0; needles < 2; needles++) {
        (needles ? make_needles : make_large_soup)(MOST_TRIANGLES);
        set_points(1, 0);
        options.threads = 1;
        options.progress = NULL;
        CHECK_EQUAL(find(&options, &one), PBW_OK);
        for (options.threads = 2; options.threads < 8; options.threads++) {
            watch w;
            watch_start(&w, 0);
            options.progress = watch_progress;
            options.progress_user = &w;
            CHECK_EQUAL(find(&options, &f), PBW_OK);
            CHECK(same_faults(&one, &f)
                  && memcmp(one.segments, f.segments, 6 * f.crossing_count * sizeof *f.segments) == 0);
            CHECK(w.wrong == 0 && w.stages == 1 << PBW_STAGE_WORK);
            pbw_surface_faults_free(&f);
        }
        pbw_surface_faults_free(&one);
    }
    test_end();
}

/* Small soups with corners on a lattice: winding numbers by open edges are those by sums of all solid angles.  Rays
   pass through corners and edges, edges have many triangles, triangles have a corner twice, and each allocation
   fails.  Where open edges are many, they are not listed. */
static void test_open(void)
{
    pbw_options options = { 0 };
    meter m;
    long i;
    if (!test_begin("winding numbers by open edges")) {
        return;
    }
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &m;
    for (i = 0; i < test_count / 5; i++) {
        const int is_long = i % 50 == 0;
        const int away = (int)(i % 3);                   /* places: on the lattice, between, anywhere */
        const size_t points = is_long ? 600 : (size_t)(4 + below(12)), count = is_long ? 200 : (size_t)(1 + below(8));
        pbw_surface tree;
        pbw_status status;
        size_t k, tests = 0;
        for (k = 0; k < 3 * points; k++) {
            s.points[k] = (double)below(4);
        }
        for (k = 0; k < 3 * count; k++) {
            s.triangles[k] = is_long ? (pbw_index)k : (pbw_index)below((whole)points);
        }
        meter_start(&m, i % 2 == 0 ? 0 : 1 + i / 2 % 15, 0);
        status = pbw_surface_create(s.points, points, s.triangles, count, &options, &tree);
        status = status == PBW_OK ? pbwsf__find_open(&tree, &options) : status;
        CHECK(status == (m.refused > 0 ? PBW_ERROR_MEMORY : PBW_OK) && (i % 2 == 1 || status == PBW_OK));
        CHECK(status != PBW_OK || ((const pbwsf__tree *)tree.memory)->has_open == !is_long);
        for (k = 0; k < 50 && status == PBW_OK && !is_long; k++) {
            double p[3], place[3], sum = 0;
            size_t t;
            int axis;
            for (axis = 0; axis < 3; axis++) {
                p[axis] = away == 2 ? (double)below(1 << 30) / (1 << 28)
                        : (double)below(8) / (1 + away) - (axis == 2);
            }
            if (pbw_surface_closest(&tree, p, 1e-6, place) == PBW_NONE) {       /* not on it */
                for (t = 0; t < count; t++) {
                    sum += pbwsf__angle(&tree, (pbw_index)t, p);
                }
                if (!CHECK(fabs(pbw_surface_winding(&tree, p) - sum) < 1e-9)) {
                    test_say("soup %ld: %g, and by triangles %g", i, pbw_surface_winding(&tree, p), sum);
                }
                tests++;
            }
        }
        CHECK(status != PBW_OK || is_long || tests > 0);
        pbw_surface_free(&tree);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    test_end();
}

/* Fails each allocation, sets limits, and cancels at each question. */
static void fail_search(void)
{
    pbw_surface_faults one, f;
    meter m;
    watch w;
    long i;
    pbw_options options = { 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    set_points(1, 0);
    CHECK_EQUAL(find(NULL, &one), PBW_OK);
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &m;
    for (i = 1; status == PBW_ERROR_MEMORY && i < 1000; i++) {
        meter_start(&m, i, (int)(i % 2));
        status = find(&options, &f);
        CHECK(status == PBW_OK ? m.refused == 0 && same_faults(&one, &f) : m.blocks == 0 && f.memory == NULL);
        pbw_surface_faults_free(&f);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    CHECK(status == PBW_OK && i > 20);
    meter_start(&m, 0, 0);
    CHECK_EQUAL(find(&options, &f), PBW_OK);
    pbw_surface_faults_free(&f);
    options.memory_limit = m.peak;
    CHECK_EQUAL(find(&options, &f), PBW_OK);
    pbw_surface_faults_free(&f);
    options.memory_limit = m.peak / 2;
    CHECK_EQUAL(find(&options, &f), PBW_ERROR_MEMORY);
    options.memory_limit = 0;
    options.progress = watch_progress;
    options.progress_user = &w;
    for (i = 1, status = PBW_CANCELLED; status == PBW_CANCELLED && i < 1000; i++) {
        watch_start(&w, i);
        status = find(&options, &f);
        CHECK(status == PBW_CANCELLED ? f.memory == NULL : w.calls < i);
        pbw_surface_faults_free(&f);
    }
    CHECK(status == PBW_OK && i > 10 && m.blocks == 0);
    pbw_surface_faults_free(&one);
}

static void test_failures(void)
{
    if (test_begin("failing allocations, limits, cancelling")) {
        make_large_soup(100);
        fail_search();
        make_needles(MOST_TRIANGLES);
        fail_search();
        test_end();
    }
}

/* Returns how many steps the search for crossings takes in a closed row of turned needles: side by side in a plane, or
   around a waist, where no two are parallel.  room: 6 * needles doubles; ids: 6 * needles numbers. */
static size_t steps_of_needles(size_t needles, int around, double *room, pbw_index *ids)
{
    const double c = cos(0.7), d = sin(0.7), e = cos(0.3), g = sin(0.3);
    pbw_surface_faults f = { 0 };
    pbwsf__search search;
    size_t i, steps = 0;
    for (i = 0; i < 2 * needles; i++) {
        const size_t end = i / needles, at = i % needles, next = (at + 1) % needles;
        const double angle = 6.283185307179586 * (double)at / (double)needles + (double)(2 * end);
        const double x = around ? cos(angle) : (double)at / (double)needles, y = around ? sin(angle) : (double)end;
        const double z = around ? 3 * (double)end : (double)(at == 0);
        room[3 * i] = c * x - d * y;
        room[3 * i + 1] = e * (d * x + c * y) - g * z;
        room[3 * i + 2] = g * (d * x + c * y) + e * z;
        ids[3 * i] = (pbw_index)(end == 0 ? at : next);
        ids[3 * i + 1] = (pbw_index)(end == 0 ? next : needles + next);
        ids[3 * i + 2] = (pbw_index)(needles + at);
    }
    CHECK_EQUAL(pbwsf__start_search(room, 2 * needles, ids, 2 * needles, NULL, &search), PBW_OK);
    CHECK_EQUAL(pbwsf__find_all(&search), PBW_OK);
    for (i = 0; i < search.steps.count; i++) {
        steps += search.steps.at[i];
    }
    CHECK(search.rods.count > 0 && search.found->crossings.count == 0 && search.found->edges.count == 4 * needles);
    pbwsf__free_search(&search);
    f.memory = search.found;
    pbw_surface_faults_free(&f);
    return steps;
}

static void test_needles(void)
{
    enum { NEEDLES = 8000 };
    double *room;
    pbw_index *ids;
    int around;
    if (!test_begin("steps of a search in rows of %d and %d needles", NEEDLES / 4, (int)NEEDLES)) {
        return;
    }
    room = (double *)zoo_grow(NULL, 6 * NEEDLES * sizeof *room);
    ids = (pbw_index *)zoo_grow(NULL, 6 * NEEDLES * sizeof *ids);
    for (around = 0; around < 2; around++) {
        const size_t few = steps_of_needles(NEEDLES / 4, around, room, ids);
        const size_t many = steps_of_needles(NEEDLES, around, room, ids);
        CHECK(many < 5 * few && many < 40 * NEEDLES);
        test_say("%s: %zu and %zu steps", around ? "around a waist" : "in a plane", few, many);
    }
    free(room);
    free(ids);
    test_end();
}

/* Many triangles around one point, many at one edge, many at one place: time that the input's size explains. */
static void test_crowds(void)
{
    enum { CROWD = 20000 };
    double *points;
    pbw_index *triangles;
    pbw_surface_faults f;
    size_t i;
    if (!test_begin("a cone of %d triangles, and one of them %d times", (int)CROWD, (int)CROWD)) {
        return;
    }
    points = (double *)zoo_grow(NULL, (CROWD + 2) * 3 * sizeof *points);
    triangles = (pbw_index *)zoo_grow(NULL, 2 * CROWD * 3 * sizeof *triangles);
    for (i = 0; i <= CROWD + 1; i++) {
        points[3 * i] = i >= CROWD ? 0 : cos(6.283185307179586 * (double)i / CROWD);
        points[3 * i + 1] = i >= CROWD ? 0 : sin(6.283185307179586 * (double)i / CROWD);
        points[3 * i + 2] = i == CROWD;
    }
    for (i = 0; i < CROWD; i++) {
        triangles[3 * i] = CROWD;
        triangles[3 * i + 1] = (pbw_index)i;
        triangles[3 * i + 2] = (pbw_index)((i + 1) % CROWD);
    }
    CHECK_EQUAL(pbw_surface_crossings(points, CROWD + 1, triangles, CROWD, NULL, &f), PBW_OK);
    CHECK(f.crossing_count == 0 && f.edge_count == CROWD && f.edge_triangles[CROWD - 1] == 1);
    pbw_surface_faults_free(&f);
    for (i = 0; i < 3 * CROWD; i += 3) {             /* a floor */
        triangles[3 * CROWD + i] = CROWD + 1;
        triangles[3 * CROWD + i + 1] = triangles[i + 2];
        triangles[3 * CROWD + i + 2] = triangles[i + 1];
    }
    CHECK_EQUAL(pbw_surface_crossings(points, CROWD + 2, triangles, 2 * CROWD, NULL, &f), PBW_OK);
    CHECK(f.crossing_count == 0 && f.edge_count == 0);
    pbw_surface_faults_free(&f);
    for (i = 0; i < 3 * CROWD; i++) {
        triangles[i] = (pbw_index)((i % 3 + i / 3) % 3);
    }
    CHECK_EQUAL(pbw_surface_crossings(points, CROWD + 1, triangles, CROWD, NULL, &f), PBW_OK);
    CHECK(f.crossing_count == 0 && f.duplicate_count == CROWD - 1 && f.edge_count == 3 && f.duplicates[1] == 0);
    CHECK(f.edge_triangles[2] == CROWD);
    pbw_surface_faults_free(&f);
    free(points);
    free(triangles);
    test_end();
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 10000);
    test_soups();
    test_magnitudes();
    test_nearly();
    test_refusals();
    test_empty();
    test_open();
    test_threads();
    test_failures();
    test_needles();
    test_crowds();
    return test_finish();
}
