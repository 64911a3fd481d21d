/* test_improve.c: improved meshes: better, positive, with the boundary, the regions and the fixed points they had;
   the measures; surfaces to slide on; and sound after every failure. */
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_ADAPT3_IMPLEMENTATION
#include "pbw_adapt3.h"
#include "pbw_query.h"
#include "meter.h"
#include "test.h"
#include "watch.h"
#include "zoo.h"
#include <math.h>

static uint64_t state;

static const double x_origin[3] = { 0, 0, 0 };

static double uniform(void)
{
    uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) / 9007199254740992.0;
}

static void *take(size_t bytes)
{
    return zoo_grow(NULL, bytes + 1);
}

/* A lattice of 7^3 points in the unit cube, each moved by up to a third of a cell, those on sides and edges along
   them; turned: rotated, so that rounding makes the sides uneven. */
static double *cube_points(int turned)
{
    double *x = (double *)take(343 * 3 * sizeof(double));
    size_t i, k;
    state = test_seed;
    for (i = 0; i < 343; i++) {
        for (k = 0; k < 3; k++) {
            const size_t at = k == 0 ? i % 7 : k == 1 ? i / 7 % 7 : i / 49;
            x[3 * i + k] = ((double)at + (at > 0 && at < 6 ? (uniform() - 0.5) / 1.5 : 0)) / 6;
        }
        for (k = 0; k < 3 && turned; k++) {
            const double a = x[3 * i + k], b = x[3 * i + (k + 1) % 3];
            x[3 * i + k] = a * 0.8 - b * 0.6;
            x[3 * i + (k + 1) % 3] = a * 0.6 + b * 0.8;
        }
    }
    return x;
}

static double *ball_points(size_t count, int on_sphere)
{
    double *x = (double *)take(count * 3 * sizeof(double));
    size_t i;
    int k;
    state = test_seed;
    for (i = 0; i < count; i++) {
        double length = 0;
        for (k = 0; k < 3; k++) {
            x[3 * i + (size_t)k] = uniform() + uniform() + uniform() + uniform() - 2;
            length += x[3 * i + (size_t)k] * x[3 * i + (size_t)k];
        }
        for (k = 0; k < 3; k++) {
            x[3 * i + (size_t)k] *= on_sphere || i % 2 == 0 ? 1 / sqrt(length) : cbrt(uniform()) / sqrt(length);
        }
    }
    return x;
}

/* Leaves out the tetrahedra between points of one side, which rounding makes; returns the new corners. */
static pbw_index *without_flat(pbw_tets *t)
{
    pbw_index *corners = (pbw_index *)take(16 * t->tet_count);
    size_t i, count = 0;
    for (i = 0; i < t->tet_count; i++) {
        const pbw_index *c = t->corners + 4 * i;
        if (pbw_tet_measure(PBW_MEASURE_VOLUME, t->points + 3 * (size_t)c[0], t->points + 3 * (size_t)c[1],
                            t->points + 3 * (size_t)c[2], t->points + 3 * (size_t)c[3]) > 1e-12) {
            memcpy(corners + 4 * count++, c, 16);
        }
    }
    t->tet_count = count;
    t->corners = corners;
    return corners;
}

static pbw_tets view(const pbw_mesh *mesh)
{
    pbw_tets tets;
    memset(&tets, 0, sizeof tets);
    tets.points = mesh->points;
    tets.point_count = mesh->point_count;
    tets.corners = mesh->simplices;
    tets.tet_count = mesh->simplex_count;
    return tets;
}

/* ---- what must hold of a result ---- */

static int compare_edges(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Euler number of the boundary: points - edges + facets; -999 if an edge has other than two facets. */
static long boundary_euler(const pbw_tets *t)
{
    uint64_t *edge = (uint64_t *)take((12 * t->tet_count + 1) * sizeof *edge);
    char *used = (char *)take(t->point_count + 1);
    size_t count = 0, points = 0, i, k, edges = 0;
    long euler;
    memset(used, 0, t->point_count + 1);
    for (i = 0; i < 4 * t->tet_count; i++) {
        for (k = 0; t->neighbors[i] == PBW_NONE && k < 3; k++) {
            const uint64_t a = t->corners[i / 4 * 4 + (i + 1 + k) % 4];
            const uint64_t b = t->corners[i / 4 * 4 + (i + 1 + (k + 1) % 3) % 4];
            edge[count++] = a < b ? a << 32 | b : b << 32 | a;
            points += !used[a];
            used[a] = 1;
        }
    }
    qsort(edge, count, sizeof *edge, compare_edges);
    for (i = 0, euler = 0; i < count && euler == 0; i += 2) {
        edges++;
        if (i + 1 == count || edge[i] != edge[i + 1] || (i + 2 < count && edge[i + 2] == edge[i])) {
            euler = -999;
        }
    }
    free(edge);
    free(used);
    return euler != 0 ? euler : (long)points - (long)edges + (long)(count / 3);
}

static int is_sound(const pbw_tets *t)
{
    char *used = (char *)take(t->point_count + 1);
    size_t i, k, orphans = t->point_count;
    int sound = 1;
    memset(used, 0, t->point_count + 1);
    for (i = 0; i < t->tet_count && sound; i++) {
        const pbw_index *c = t->corners + 4 * i;
        for (k = 0; k < 4 && sound; k++) {
            const pbw_index n = t->neighbors[4 * i + k];
            sound = c[k] < t->point_count && (n == PBW_NONE || n < t->tet_count);
            if (sound) {
                orphans -= !used[c[k]];
                used[c[k]] = 1;
            }
            if (sound && n != PBW_NONE) {
                const pbw_index *b = t->neighbors + 4 * (size_t)n;
                sound = b[0] == i || b[1] == i || b[2] == i || b[3] == i;
            }
        }
        sound = sound && pbw_orient3(t->points + 3 * (size_t)c[0], t->points + 3 * (size_t)c[1],
                                     t->points + 3 * (size_t)c[2], t->points + 3 * (size_t)c[3]) > 0;
    }
    free(used);
    return sound && orphans == 0;
}

/* ---- tests ---- */

static int near(double a, double b)
{
    return fabs(a - b) <= 1e-12 * (fabs(a) + fabs(b));
}

/* The spread of values of which some are no numbers, as of tetrahedra that are points: in any order the same. */
static void test_spread(void)
{
    enum { TETS = 60 };
    static const double points[15] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 5 };
    pbw_index corners[4 * TETS];
    pbw_tets mesh;
    pbw_spread spread;
    size_t step, i;
    if (!test_begin("the spread of values that are no numbers")) {
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    mesh.points = points;
    mesh.point_count = 5;
    mesh.corners = corners;
    mesh.tet_count = TETS;
    for (step = 1; step < TETS; step++) {
        for (i = 0; i < TETS; i++) {
            const pbw_index kind = (pbw_index)(i * step % TETS % 3);         /* a point, a short one, a long one */
            corners[4 * i] = 0;
            corners[4 * i + 1] = kind > 0 ? 1 : 0;
            corners[4 * i + 2] = kind > 0 ? 2 : 0;
            corners[4 * i + 3] = kind == 0 ? 0 : kind + 2;
        }
        corners[0] = corners[1] = corners[2] = corners[3] = 0;
        for (i = 0; i < 3; i++) {                    /* at least one of each */
            corners[4 * i + 4] = 0;
            corners[4 * i + 5] = i > 0 ? 1 : 0;
            corners[4 * i + 6] = i > 0 ? 2 : 0;
            corners[4 * i + 7] = i == 0 ? 0 : (pbw_index)i + 2;
        }
        CHECK(pbw_tets_spread(&mesh, PBW_MEASURE_EDGE_RATIO, NULL, &spread));
        CHECK(near(spread.least, sqrt(2.0)) && spread.permille >= spread.least && !(spread.most <= HUGE_VAL));
    }
    test_end();
}

static void test_measures(void)
{
    static const double o[3] = { 0, 0, 0 }, x[3] = { 1, 0, 0 }, y[3] = { 0, 1, 0 }, z[3] = { 0, 0, 1 };
    static const double r[4][3] = { { 1, 1, 1 }, { -1, -1, 1 }, { -1, 1, -1 }, { 1, -1, -1 } };
    static const double best[] = { 0, 0, 0, 0, 1, 1, 1, 0, 1, 1, 1, 1, 1, 1 };
    int i;
    if (!test_begin("measures")) {
        return;
    }
    for (i = 0; pbw_measure_name((pbw_measure)i) != NULL; i++) {
        const double value = pbw_tet_measure((pbw_measure)i, r[0], r[1], r[2], r[3]);
        CHECK(best[i] <= 0 || near(value, best[i]));
        if (best[i] > 0 && !near(value, best[i])) {
            test_say("%s: %.17g", pbw_measure_name((pbw_measure)i), value);
        }
    }
    CHECK_EQUAL(i, PBW_MEASURES);
    CHECK(near(pbw_tet_measure(PBW_MEASURE_LEAST_DIHEDRAL, r[0], r[1], r[2], r[3]), acos(1 / 3.) * 180 / acos(-1)));
    /* The corner of a cube: edges 1, 1, 1 and sqrt 2; R = sqrt 3 / 2; r = 1 / (3 + sqrt 3). */
    CHECK(near(pbw_tet_measure(PBW_MEASURE_VOLUME, o, x, y, z), 1 / 6.));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_VOLUME, o, y, x, z), -1 / 6.));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_LARGEST_DIHEDRAL, o, x, y, z), 90));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_LEAST_DIHEDRAL, o, x, y, z), acos(1 / sqrt(3)) * 180 / acos(-1)));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_LEAST_SINE, o, x, y, z), sqrt(2 / 3.)));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_RADIUS_EDGE, o, x, y, z), sqrt(3) / 2));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_GAMMA, o, x, y, z), 6 / (3 + sqrt(3)) / sqrt(3)));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_ETA, o, x, y, z), 12 * pow(0.5, 2 / 3.) / 9));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_ASPECT_RATIO, o, x, y, z), (3 + sqrt(3)) / (2 * sqrt(3))));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_EDGE_RATIO, o, x, y, z), sqrt(2)));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_ASPECT_GAMMA, o, x, y, z), pow(1.5, 1.5) * sqrt(2) / 2));
    CHECK(near(pbw_tet_measure(PBW_MEASURE_SCALED_JACOBIAN, o, x, y, z), sqrt(2) / 2));
    test_end();
}

/* The hull of a mesh, outward. */
static size_t hull_of(const pbw_mesh *mesh, pbw_index *triangles)
{
    static const int across[4][3] = { { 1, 2, 3 }, { 0, 3, 2 }, { 0, 1, 3 }, { 0, 2, 1 } };
    size_t count = 0, i, k;
    for (i = 0; i < 4 * mesh->simplex_count; i++) {
        for (k = 0; mesh->neighbors[i] == PBW_NONE && k < 3; k++) {
            triangles[3 * count + k] = mesh->simplices[i / 4 * 4 + (size_t)across[i % 4][k]];
        }
        count += mesh->neighbors[i] == PBW_NONE;
    }
    return count;
}

/* Inside is what the triangulation has; nearest is checked by trying all triangles. */
static void test_surface(int lattice)
{
    const size_t count = lattice ? 125 : 300;
    double *x = lattice ? (double *)take(375 * sizeof(double)) : ball_points(count, 1);
    pbw_index *triangles;
    pbw_mesh mesh;
    pbw_surface surface;
    size_t triangle_count, i, k;
    if (!test_begin("surface: %s", lattice ? "lattice" : "sphere")) {
        free(x);
        return;
    }
    for (i = 0; i < 375 && lattice; i++) {
        x[i] = (double)(i % 3 == 0 ? i / 3 % 5 : i % 3 == 1 ? i / 15 % 5 : i / 75);
    }
    memset(&mesh, 0, sizeof mesh);
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, count, NULL, &mesh), PBW_OK);
    triangles = (pbw_index *)take(12 * mesh.simplex_count * sizeof *triangles);
    triangle_count = hull_of(&mesh, triangles);
    CHECK_EQUAL(pbw_surface_create(x, count, triangles, triangle_count, NULL, &surface), PBW_OK);
    for (i = 0; i < 1000; i++) {
        double p[3], place[3], other[3], where, best = HUGE_VAL, none[3] = { 50, 60, 70 };
        for (k = 0; k < 3; k++) {
            p[k] = lattice ? floor(6 * uniform()) - (k == 2 ? 0.5 : 0) : 2.4 * uniform() - 1.2;
        }
        if (!lattice || (p[0] > 0 && p[0] < 4 && p[1] > 0 && p[1] < 4) || p[0] > 4 || p[1] > 4) {
            const int inside = pbw_locate_one(&mesh, p, PBW_NONE, NULL) != PBW_NONE;
            CHECK_EQUAL(pbw_surface_inside(&surface, p), inside);
            CHECK(fabs(pbw_surface_winding(&surface, p) - inside) < 0.1);
            CHECK(!inside || pbw_surface_meets(&surface, p, none, &where) != PBW_NONE);
        }
        CHECK(pbw_surface_closest(&surface, p, HUGE_VAL, place) < triangle_count);
        for (k = 0; k < triangle_count; k++) {
            const double *a = x + 3 * (size_t)triangles[3 * k], *b = x + 3 * (size_t)triangles[3 * k + 1];
            pbwsf__nearest_in(a, b, x + 3 * (size_t)triangles[3 * k + 2], p, other);
            best = fmin(best, pbwsf__distance(p, other));
        }
        CHECK(near(pbwsf__distance(p, place), best) || best < 1e-12);
    }
    pbw_surface_free(&surface);
    pbw_surface_free(&surface);
    pbw_free(&mesh);
    free(triangles);
    free(x);
    test_end();
}

/* The sides stay planes, the edges stay edges: the volume is kept. */
static void test_cube(int turned)
{
    const size_t count = 343;
    double *x = cube_points(turned);
    pbw_improve_options how;
    pbw_improve_report report;
    pbw_mesh mesh;
    pbw_tets in, out;
    pbw_index *flat;
    size_t i;
    double last = -1;
    if (!test_begin("cube%s", turned ? ", turned" : "")) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&how, 0, sizeof how);
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, count, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    flat = without_flat(&in);
    for (how.passes = 1; how.passes <= 32; how.passes *= 2) {
        CHECK_EQUAL(pbw_improve(&in, &how, NULL, &out, &report), PBW_OK);
        CHECK(is_sound(&out));
        CHECK_EQUAL(boundary_euler(&out), 2);
        CHECK(report.after.least_sine >= report.before.least_sine - 1e-12 && report.after.least_sine >= last - 1e-12);
        CHECK(fabs(report.after.volume - report.before.volume) < 1e-9);
        last = report.after.least_sine;
        for (i = 0; i < out.point_count; i++) {      /* fixed points did not move, and none is lost */
            const pbw_index was = out.original[i];
            CHECK(out.marks[i] != PBW_TETS_FIXED || (was != PBW_NONE
                  && memcmp(out.points + 3 * i, x + 3 * (size_t)was, 3 * sizeof *x) == 0));
        }
        pbw_tets_free(&out);
    }
    test_say("%.2f..%.2f to %.2f..%.2f, %zu below", report.before.least, report.before.largest, report.after.least,
             report.after.largest, report.left);
    CHECK(report.after.least > 25 && report.before.least < 2);
    pbw_free(&mesh);
    free(flat);
    free(x);
    test_end();
}

static int same_bytes(const pbw_tets *a, const pbw_tets *b)
{
    return a->tet_count == b->tet_count && a->point_count == b->point_count
        && memcmp(a->corners, b->corners, 16 * a->tet_count) == 0
        && memcmp(a->neighbors, b->neighbors, 16 * a->tet_count) == 0
        && memcmp(a->points, b->points, 24 * a->point_count) == 0
        && memcmp(a->original, b->original, 4 * a->point_count) == 0
        && a->edge_count == b->edge_count && (a->patches == NULL) == (b->patches == NULL)
        && (a->patches == NULL || memcmp(a->patches, b->patches, 16 * a->tet_count) == 0)
        && (a->edge_count == 0 || (memcmp(a->edges, b->edges, 8 * a->edge_count) == 0
                                   && memcmp(a->edge_origins, b->edge_origins, 4 * a->edge_count) == 0));
}

/* Any number of threads makes the same bytes and counts; a budget that ends at any moment leaves a mesh no worse. */
static void check_threads(const pbw_tets *in, const pbw_tets *out, const pbw_improve_report *report)
{
    pbw_options threads;
    pbw_improve_options how;
    pbw_improve_report other;
    pbw_tets again;
    memset(&threads, 0, sizeof threads);
    memset(&how, 0, sizeof how);
    for (threads.threads = 2; threads.threads < 5; threads.threads++) {
        CHECK_EQUAL(pbw_improve(in, NULL, &threads, &again, &other), PBW_OK);
        CHECK(same_bytes(&again, out) && memcmp(&other, report, sizeof other) == 0);
        pbw_tets_free(&again);
    }
    for (how.seconds = 1e-9; how.seconds < 1; how.seconds *= 32) {
        CHECK_EQUAL(pbw_improve(in, &how, &threads, &again, &other), PBW_OK);
        CHECK(is_sound(&again) && other.after.least_sine >= other.before.least_sine - 1e-12);
        pbw_tets_free(&again);
    }
}

static void test_ball(void)
{
    const size_t count = 600;
    double *x = ball_points(count, 0);
    pbw_options threads;
    pbw_improve_report report;
    pbw_mesh mesh;
    pbw_tets in, out, again;
    pbw_index *turned;
    size_t i;
    if (!test_begin("ball")) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&threads, 0, sizeof threads);
    threads.threads = 1;
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, count, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    CHECK_EQUAL(pbw_improve(&in, NULL, &threads, &out, &report), PBW_OK);
    CHECK(is_sound(&out));
    CHECK_EQUAL(boundary_euler(&out), 2);
    CHECK_EQUAL(report.turned, 0);
    CHECK(fabs(report.after.volume - report.before.volume) < 0.04 * report.before.volume);
    CHECK(report.after.least > 15 && report.before.least < 1);
    test_say("%.2f..%.2f to %.2f..%.2f, %zu below", report.before.least, report.before.largest, report.after.least,
             report.after.largest, report.left);
    check_threads(&in, &out, &report);
    turned = (pbw_index *)take(16 * in.tet_count);
    for (i = 0; i < 4 * in.tet_count; i++) {         /* negative ones are turned */
        turned[i] = mesh.simplices[i / 8 % 2 != 0 && i % 4 < 2 ? i ^ 1 : i];
    }
    in.corners = turned;
    CHECK_EQUAL(pbw_improve(&in, NULL, NULL, &again, &report), PBW_OK);
    CHECK_EQUAL(report.turned, in.tet_count / 4 * 2 + (in.tet_count % 4 == 3));
    CHECK(is_sound(&again));
    pbw_tets_free(&again);
    pbw_tets_free(&out);
    pbw_free(&mesh);
    free(turned);
    free(x);
    test_end();
}

static void to_sphere(void *user, double point[3])
{
    const double length = pbwsf__distance(point, x_origin);
    int k;
    (void)user;
    for (k = 0; k < 3; k++) {
        point[k] /= length;
    }
}

/* The farthest from the unit sphere of the middles of boundary facets and of their edges. */
static double farthest_of(const pbw_tets *t, const pbw_index *neighbors)
{
    double worst = 0;
    size_t i, j, k;
    for (i = 0; i < 4 * t->tet_count; i++) {
        for (j = 0; j < 4 && neighbors[i] == PBW_NONE; j++) {        /* j = 3: of all three corners, else without j */
            double middle[3] = { 0, 0, 0 };
            for (k = 0; k < 9; k++) {
                const size_t corner = i / 4 * 4 + (i % 4 + 1 + k / 3) % 4;
                middle[k % 3] += k / 3 == j ? 0 : t->points[3 * (size_t)t->corners[corner] + k % 3] / (j < 3 ? 2 : 3);
            }
            worst = fmax(worst, fabs(pbwsf__distance(middle, x_origin) - 1));
        }
    }
    return worst;
}

/* Facets come no farther from the surface than the distance, or than they were. */
static void test_distance(void)
{
    double *x = ball_points(600, 0), sizes[600], before, after[2];
    pbw_improve_options how;
    pbw_mesh mesh;
    pbw_tets in, out;
    int k;
    if (!test_begin("distance from the surface")) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&how, 0, sizeof how);
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, 600, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    before = farthest_of(&in, mesh.neighbors);
    for (k = 0; k < 600; k++) {
        sizes[k] = 0.6;                              /* coarse: edges are contracted, and facets leave the sphere */
    }
    how.sizes = sizes;
    how.project = to_sphere;
    for (k = 0; k < 2; k++) {
        how.distance = k * before;
        CHECK_EQUAL(pbw_improve(&in, &how, NULL, &out, NULL), PBW_OK);
        after[k] = farthest_of(&out, out.neighbors);
        pbw_tets_free(&out);
    }
    test_say("%g, any %g, bounded %g", before, after[0], after[1]);
    CHECK(after[0] > 1.05 * before && after[1] <= before + 1e-12);
    pbw_free(&mesh);
    free(x);
    test_end();
}

/* Two regions keep their volumes, which the interface between them decides, and every third point its place. */
static void test_regions(void)
{
    const size_t count = 400;
    double *x = ball_points(count, 0), volume[2][2] = { { 0, 0 }, { 0, 0 } };
    unsigned char *marks = (unsigned char *)take(count);
    pbw_improve_options how;
    pbw_index *regions;
    pbw_mesh mesh;
    pbw_tets in, out;
    size_t i, k, fixed = 0;
    if (!test_begin("regions and marks")) {
        free(marks);
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, count, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    regions = (pbw_index *)take(in.tet_count * sizeof *regions);
    for (i = 0; i < in.tet_count; i++) {
        double sum = 0;
        for (k = 0; k < 4; k++) {
            sum += x[3 * (size_t)in.corners[4 * i + k]];
        }
        regions[i] = sum > 0 ? 7 : 9;
    }
    for (i = 0; i < count; i++) {                    /* the boundary stays, so that volumes do */
        marks[i] = i % 2 == 0 || i % 3 == 0 ? PBW_TETS_FIXED : PBW_TETS_FOUND;
    }
    in.regions = regions;
    in.marks = marks;
    memset(&how, 0, sizeof how);
    how.passes = 3;
    CHECK_EQUAL(pbw_improve(&in, &how, NULL, &out, NULL), PBW_OK);
    CHECK(is_sound(&out));
    for (i = 0; i < in.tet_count + out.tet_count; i++) {
        const pbw_tets *t = i < in.tet_count ? &in : &out;
        const size_t j = i < in.tet_count ? i : i - in.tet_count;
        const double *c[4];
        for (k = 0; k < 4; k++) {
            c[k] = t->points + 3 * (size_t)t->corners[4 * j + k];
        }
        CHECK(t->regions[j] == 7 || t->regions[j] == 9);
        volume[t == &out][t->regions[j] == 7] += pbw_tet_measure(PBW_MEASURE_VOLUME, c[0], c[1], c[2], c[3]);
    }
    CHECK(fabs(volume[0][0] - volume[1][0]) < 0.02 && fabs(volume[0][1] - volume[1][1]) < 0.02);
    for (i = 0; i < out.point_count; i++) {
        const pbw_index was = out.original[i];
        if (was != PBW_NONE && marks[was] == PBW_TETS_FIXED) {
            fixed++;
            CHECK(memcmp(out.points + 3 * i, x + 3 * (size_t)was, 24) == 0);
        }
    }
    for (i = 0; i < count; i++) {
        fixed -= marks[i] == PBW_TETS_FIXED && mesh.incident[i] != PBW_NONE;
    }
    CHECK_EQUAL(fixed, 0);
    pbw_tets_free(&out);
    pbw_free(&mesh);
    free(regions);
    free(marks);
    free(x);
    test_end();
}

static int compare_facets(const void *a, const void *b)
{
    return memcmp(a, b, 9 * sizeof(double));
}

/* Lists the facets of the boundary and between regions of which all corners have the mark: the corners' coordinates,
   in order. */
static size_t marked_facets(const pbw_tets *t, unsigned char mark, double (**list)[9])
{
    size_t count = 0, i, k;
    *list = (double (*)[9])take(4 * t->tet_count * sizeof **list);
    for (i = 0; i < 4 * t->tet_count; i++) {
        int marked = 1, at = 0;
        if (t->neighbors[i] != PBW_NONE && t->regions[t->neighbors[i]] == t->regions[i / 4]) {
            continue;
        }
        for (k = 0; k < 4; k++) {
            const pbw_index p = t->corners[i / 4 * 4 + k];
            if (k != i % 4) {
                marked &= t->marks[p] == mark;
                memcpy((*list)[count] + 3 * at++, t->points + 3 * (size_t)p, 24);
            }
        }
        for (k = 0; k < 3; k++) {                    /* sorts three corners */
            double *const low = (*list)[count] + 3 * (k % 2), swap[3] = { low[0], low[1], low[2] };
            if (memcmp(low, low + 3, 24) > 0) {
                memcpy(low, low + 3, 24);
                memcpy(low + 3, swap, 24);
            }
        }
        count += (size_t)marked;
    }
    qsort(*list, count, sizeof **list, compare_facets);
    return count;
}

/* Facets between frozen points stay to the bit, on the boundary and between regions, where all points are frozen and
   where half of them are; fixed points alone keep no facet.  With sizes, edges get points elsewhere. */
static void test_frozen(unsigned char mark, double half, int sized)
{
    const size_t count = 343;
    double *x = cube_points(0), sizes[343], (*before)[9], (*after)[9];
    unsigned char marks[343];
    pbw_index *flat, *regions;
    pbw_improve_options how;
    pbw_improve_report report;
    pbw_mesh mesh;
    pbw_tets in, same, out;
    size_t facets, i, k;
    if (!test_begin("points that are %s%s%s", mark == PBW_TETS_FROZEN ? "frozen" : "fixed", half > 0 ? ", half" : "",
                    sized ? ", sizes" : "")) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&how, 0, sizeof how);
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, count, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    flat = without_flat(&in);
    regions = (pbw_index *)take(in.tet_count * sizeof *regions);
    for (i = 0; i < in.tet_count; i++) {
        double sum = 0;
        for (k = 0; k < 4; k++) {
            sum += x[3 * (size_t)in.corners[4 * i + k] + 1];
        }
        regions[i] = sum > 2;
    }
    for (i = 0; i < count; i++) {
        marks[i] = x[3 * i] >= half ? mark : PBW_TETS_FOUND;
        sizes[i] = 0.13;
    }
    in.regions = regions;
    in.marks = marks;
    how.passes = -1;
    CHECK_EQUAL(pbw_improve(&in, &how, NULL, &same, NULL), PBW_OK);
    how.passes = sized ? 2 : 0;
    how.sizes = sized ? sizes : NULL;
    CHECK_EQUAL(pbw_improve(&in, &how, NULL, &out, &report), PBW_OK);
    CHECK(is_sound(&out));
    facets = marked_facets(&same, mark, &before);
    CHECK(facets > 100 && (report.splits > 100) == sized);
    i = marked_facets(&out, mark, &after);
    CHECK((i == facets && memcmp(before, after, facets * sizeof *before) == 0) == (mark == PBW_TETS_FROZEN));
    CHECK((report.boundary_removals + report.peelings > 0) == (mark == PBW_TETS_FIXED || half > 0));
    CHECK(fabs(report.after.volume - report.before.volume) < 1e-9 && report.after.least >= report.before.least - 1e-9);
    test_say("%zu facets stay, %.2f..%.2f to %.2f..%.2f", facets, report.before.least, report.before.largest,
             report.after.least, report.after.largest);
    free(before);
    free(after);
    pbw_tets_free(&same);
    pbw_tets_free(&out);
    pbw_free(&mesh);
    free(regions);
    free(flat);
    free(x);
    test_end();
}

/* An allocator: new bytes are 0xff, so that a number that is not set is none. */
static void *resize_unset(void *user, void *ptr, size_t old_size, size_t new_size)
{
    void *block = NULL;
    (void)user;
    if (new_size > 0) {
        block = take(new_size);
        memset(block, 0xff, new_size);
        if (ptr != NULL) {
            memcpy(block, ptr, old_size < new_size ? old_size : new_size);
        }
    }
    free(ptr);
    return block;
}

/* A cubic lattice with its cells' middles, all fixed, five pairs of them too near to each other: the first passes
   with insertion have one block, and reserve points; when more tetrahedra are bad, all points get places along
   curves, those too that are reserved and on no tetrahedron yet. */
static void test_reserved(void)
{
    enum { SIDE = 12, PAIRS = 5, POINTS = SIDE * SIDE * SIDE + (SIDE - 1) * (SIDE - 1) * (SIDE - 1) };
    static double x[POINTS][3];
    static unsigned char marks[POINTS];
    pbw_improve_report report;
    pbw_options options;
    pbw_mesh mesh;
    pbw_tets in, out;
    size_t i, k, last = 0;
    int half, pair;
    if (!test_begin("points reserved for insertions")) {
        return;
    }
    for (half = 0; half < 2; half++) {
        const size_t side = (size_t)(SIDE - half);
        for (i = 0; i < side * side * side; i++, last++) {
            x[last][0] = (double)(i % side) + 0.5 * half;
            x[last][1] = (double)(i / side % side) + 0.5 * half;
            x[last][2] = (double)(i / side / side) + 0.5 * half;
        }
    }
    for (pair = 0; pair < PAIRS; pair++) {
        const size_t at = (size_t)(3 + pair % 2 * 5 + SIDE * (3 + pair / 2 % 2 * 5 + SIDE * (3 + pair / 4 * 5)));
        for (k = 0; k < 3; k++) {
            x[at][k] += 0.4;                         /* its cell's middle is at 0.5 */
        }
    }
    memset(marks, PBW_TETS_FIXED, sizeof marks);
    memset(&options, 0, sizeof options);
    options.resize = resize_unset;
    CHECK_EQUAL(pbw_triangulate(3, x[0], NULL, POINTS, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    in.marks = marks;
    CHECK_EQUAL(pbw_improve(&in, NULL, &options, &out, &report), PBW_OK);
    CHECK(is_sound(&out) && report.insertions > 0 && report.after.least > report.before.least);
    test_say("%zu below 30 degrees, then %zu, %zu insertions", report.before.below[3], report.left,
             report.insertions);
    pbw_tets_free(&out);
    pbw_free(&mesh);
    test_end();
}

/* Only smoothing: what the mesh connects stays, the least quality too, the mean of a measure rises; points of the
   cube stay on its sides and edges; threads change nothing. */
static void test_smoothers(pbw_smoother smoother)
{
    static const char *const names[] = { "ODT", "Lloyd", "Laplacian" };
    double *x = cube_points(0), mean[2] = { 0, 0 };
    pbw_options threads;
    pbw_improve_options how;
    pbw_improve_report report;
    pbw_mesh mesh;
    pbw_tets in, out, again;
    pbw_index *flat;
    size_t i, k;
    if (!test_begin("smoother: %s", names[smoother])) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&how, 0, sizeof how);
    memset(&threads, 0, sizeof threads);
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, 343, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    flat = without_flat(&in);
    how.passes = -1;
    how.rounds = 4;
    how.smoother = smoother;
    threads.threads = 1;
    CHECK_EQUAL(pbw_improve(&in, &how, &threads, &out, &report), PBW_OK);
    CHECK(is_sound(&out) && report.rounds == 4 && report.moves > 300 && report.passes == 0);
    CHECK(out.tet_count == in.tet_count && memcmp(out.corners, in.corners, 16 * in.tet_count) == 0);
    CHECK(fabs(report.after.volume - 1) < 1e-9 && report.after.least_sine >= report.before.least_sine - 1e-12);
    for (i = 0; i < 2 * in.tet_count; i++) {
        const pbw_tets *t = i % 2 == 0 ? &in : &out;
        const pbw_index *c = t->corners + 4 * (i / 2);
        mean[i % 2] += pbw_tet_measure(PBW_MEASURE_ETA, t->points + 3 * (size_t)c[0], t->points + 3 * (size_t)c[1],
                                       t->points + 3 * (size_t)c[2], t->points + 3 * (size_t)c[3])
                     / (double)in.tet_count;
    }
    test_say("mean eta %.4f to %.4f, %zu moves", mean[0], mean[1], report.moves);
    CHECK(mean[1] > mean[0] + 0.01);
    for (i = 0; i < 3 * 343; i++) {
        const size_t at = i % 3 == 0 ? i / 3 % 7 : i % 3 == 1 ? i / 21 % 7 : i / 147;
        CHECK(at % 6 != 0 || fabs(out.points[i] - (double)at / 6) < 1e-12);
    }
    for (k = 2; k <= 4; k += 2) {
        threads.threads = (int)k;
        CHECK_EQUAL(pbw_improve(&in, &how, &threads, &again, NULL), PBW_OK);
        CHECK(memcmp(again.points, out.points, 24 * out.point_count) == 0);
        pbw_tets_free(&again);
    }
    how.smoother = (pbw_smoother)3;
    CHECK_EQUAL(pbw_improve(&in, &how, &threads, &again, NULL), PBW_ERROR_ARGUMENT);
    pbw_tets_free(&out);
    pbw_free(&mesh);
    free(flat);
    free(x);
    test_end();
}

static double ratio_of(const pbw_tets *t, size_t i, int k)
{
    static const int edge[6][2] = { { 0, 1 }, { 0, 2 }, { 0, 3 }, { 1, 2 }, { 1, 3 }, { 2, 3 } };
    const double *a = t->points + 3 * (size_t)t->corners[4 * i + (size_t)edge[k][0]];
    const double *b = t->points + 3 * (size_t)t->corners[4 * i + (size_t)edge[k][1]];
    const double size = 0.06 + 0.15 * (pbwsf__distance(a, x_origin) + pbwsf__distance(b, x_origin));
    return pbwsf__distance(a, b) / size;
}

/* Edges get the lengths that sizes say, fine at a corner of the cube, coarse across; two regions keep their volumes,
   and the cube its edges. */
static void test_sizes(int rounds)
{
    double *x = cube_points(0), sizes[343], volume[2] = { 0, 0 };
    pbw_improve_options how;
    pbw_improve_report report;
    pbw_mesh mesh;
    pbw_tets in, out;
    pbw_index *flat, *regions;
    size_t i, k, wrong = 0;
    if (!test_begin("sizes%s", rounds > 0 ? ", and smoothed" : "")) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&how, 0, sizeof how);
    for (i = 0; i < 343; i++) {                      /* a lattice is in two halves */
        for (k = 0; k < 3; k++) {
            const size_t at = k == 0 ? i % 7 : k == 1 ? i / 7 % 7 : i / 49;
            x[3 * i + k] = k == 0 && at == 3 ? 0.5 : x[3 * i + k];
        }
        sizes[i] = 0.06 + 0.3 * pbwsf__distance(x + 3 * i, x_origin);
    }
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, 343, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    flat = without_flat(&in);
    regions = (pbw_index *)take(in.tet_count * sizeof *regions);
    for (i = 0; i < in.tet_count; i++) {
        double sum = 0;
        for (k = 0; k < 4; k++) {
            sum += x[3 * (size_t)in.corners[4 * i + k]];
        }
        regions[i] = sum < 2;
    }
    in.regions = regions;
    how.sizes = sizes;
    how.rounds = rounds;
    CHECK_EQUAL(pbw_improve(&in, &how, NULL, &out, &report), PBW_OK);
    CHECK(is_sound(&out));
    CHECK_EQUAL(boundary_euler(&out), 2);
    CHECK(report.splits > 100 && report.contractions > 10 && fabs(report.after.volume - 1) < 1e-9);
    for (i = 0; i < out.tet_count; i++) {
        const pbw_index *c = out.corners + 4 * i;
        volume[out.regions[i] != 0] += pbw_tet_measure(PBW_MEASURE_VOLUME, out.points + 3 * (size_t)c[0],
            out.points + 3 * (size_t)c[1], out.points + 3 * (size_t)c[2], out.points + 3 * (size_t)c[3]);
        for (k = 0; k < 6; k++) {
            wrong += ratio_of(&out, i, (int)k) > 1.7;
        }
    }
    test_say("%zu to %zu tetrahedra, %zu splits, %zu edges too long, %.2f..%.2f, volume %.15g", in.tet_count,
             out.tet_count, report.splits, wrong, report.after.least, report.after.largest, volume[1]);
    CHECK(fabs(volume[1] - 0.5) < 1e-9);
    CHECK(wrong * 200 < out.tet_count && report.after.permille > 10);
    sizes[7] = 0;
    pbw_tets_free(&out);
    CHECK_EQUAL(pbw_improve(&in, &how, NULL, &out, NULL), PBW_ERROR_ARGUMENT);
    pbw_free(&mesh);
    free(regions);
    free(flat);
    free(x);
    test_end();
}

/* A ball with a linear field, carried over to other points, some outside; every allocation fails in turn. */
static void test_transfer(void)
{
    double *x = ball_points(500, 0), *to = ball_points(500, 0), field[500] = { 0 }, out[500];
    double low = HUGE_VAL, high = -HUGE_VAL;
    pbw_options options;
    pbw_mesh mesh;
    pbw_tets in, other;
    pbw_status status = PBW_ERROR_MEMORY;
    meter m;
    size_t most, i;
    long k;
    if (!test_begin("fields carried over")) {
        free(x);
        free(to);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&other, 0, sizeof other);
    memset(&options, 0, sizeof options);
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, 500, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    CHECK_EQUAL(pbw_tets_transfer(&in, &other, field, 1, NULL, out), PBW_ERROR_ARGUMENT);    /* no neighbours */
    in.neighbors = mesh.neighbors;
    for (i = 0; i < 500; i++) {
        for (k = 0; k < 3; k++) {
            to[3 * i + (size_t)k] *= i < 250 ? 0.7 : 1.3;
        }
        field[i] = 3 * x[3 * i] - x[3 * i + 1] + 2 * x[3 * i + 2] + 1;
        low = fmin(low, field[i]);
        high = fmax(high, field[i]);
    }
    other.points = to;
    other.point_count = 500;
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &m;
    for (k = 1; status == PBW_ERROR_MEMORY && k < 1000; k++) {
        meter_start(&m, k, 1);
        status = pbw_tets_transfer(&in, &other, field, 1, &options, out);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    CHECK(status == PBW_OK && k > 4);
    most = m.peak;
    for (k = 1; k <= 30; k++) {                      /* no call holds more than its limit */
        options.memory_limit = most * (size_t)k / 20;
        meter_start(&m, 0, 0);
        status = pbw_tets_transfer(&in, &other, field, 1, &options, out);
        CHECK(status == (m.peak < most ? PBW_ERROR_MEMORY : PBW_OK) && m.peak <= options.memory_limit);
    }
    CHECK_EQUAL(status, PBW_OK);
    for (i = 0; i < 500; i++) {
        const double due = 3 * to[3 * i] - to[3 * i + 1] + 2 * to[3 * i + 2] + 1;
        CHECK(out[i] >= low - 1e-12 && out[i] <= high + 1e-12);
        CHECK(i >= 250 || fabs(out[i] - due) < 1e-12);
    }
    pbw_free(&mesh);
    free(x);
    free(to);
    test_end();
}

/* The one free point of an octahedron, at 0.2 on an axis: the mean of its neighbours is 0, the weighted mean of the
   circumcentres too; its Voronoi cell is |y|, |z| < 0.48 + 0.2 x for x from -0.4 to 0.6, with centroid
   0.126 / 0.76. */
static void test_aims(void)
{
    static const double x[21] = { 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0.2, 0, 0 };
    static const double aim[3] = { 0, 0.126 / 0.76, 0 };
    pbw_index corners[32];
    pbw_improve_options how;
    pbw_tets in, out;
    pbw_index i, k;
    if (!test_begin("where smoothers aim")) {
        return;
    }
    for (i = 0; i < 8; i++) {
        for (k = 0; k < 3; k++) {
            corners[4 * i + k] = 2 * k + (i >> k & 1);
        }
        corners[4 * i + 3] = 6;
    }
    memset(&how, 0, sizeof how);
    memset(&in, 0, sizeof in);
    in.points = x;
    in.point_count = 7;
    in.corners = corners;
    in.tet_count = 8;
    how.passes = -1;
    how.rounds = 1;
    for (k = 0; k < 3; k++) {
        how.smoother = (pbw_smoother)k;
        CHECK_EQUAL(pbw_improve(&in, &how, NULL, &out, NULL), PBW_OK);
        CHECK(memcmp(out.points, x, 18 * sizeof *x) == 0);
        CHECK(fabs(out.points[18] - aim[k]) < 1e-14 && fabs(out.points[19]) + fabs(out.points[20]) < 1e-14);
        pbw_tets_free(&out);
    }
    test_end();
}

static void test_refused(void)
{
    static const double x[18] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0.1, 0.1, 0.5 };
    static const pbw_index range[4] = { 0, 1, 2, 9 }, twice[4] = { 0, 1, 2, 1 };
    static const pbw_index crowd[12] = { 0, 1, 2, 3, 0, 2, 1, 4, 0, 1, 2, 5 };
    static const pbw_index overlap[8] = { 0, 1, 2, 3, 0, 1, 2, 5 };
    static const pbw_index good[8] = { 0, 1, 2, 3, 0, 2, 1, 4 };
    char text[100] = "";
    pbw_options options;
    pbw_improve_options how;
    pbw_tets in, out;
    double bad[18];
    if (!test_begin("refused")) {
        return;
    }
    memset(&options, 0, sizeof options);
    memset(&how, 0, sizeof how);
    memset(&in, 0, sizeof in);
    options.message = text;
    options.message_size = sizeof text;
    in.points = x;
    in.point_count = 6;
    CHECK_EQUAL(pbw_improve(&in, NULL, &options, &out, NULL), PBW_OK);       /* nothing is fine */
    pbw_tets_free(&out);
    in.tet_count = 1;
    in.corners = range;
    CHECK_EQUAL(pbw_improve(&in, NULL, &options, &out, NULL), PBW_ERROR_ARGUMENT);
    CHECK(strstr(text, "tetrahedron 0 ") != NULL);
    in.corners = twice;
    CHECK_EQUAL(pbw_improve(&in, NULL, &options, &out, NULL), PBW_ERROR_ARGUMENT);
    in.corners = crowd;
    in.tet_count = 3;
    CHECK_EQUAL(pbw_improve(&in, NULL, &options, &out, NULL), PBW_ERROR_ARGUMENT);
    CHECK(strstr(text, "others have") != NULL);
    in.corners = overlap;
    in.tet_count = 2;
    CHECK_EQUAL(pbw_improve(&in, NULL, &options, &out, NULL), PBW_ERROR_ARGUMENT);
    CHECK(strstr(text, "0 and 1 overlap") != NULL);
    in.corners = good;
    CHECK_EQUAL(pbw_improve(&in, NULL, &options, &out, NULL), PBW_OK);
    CHECK_EQUAL(out.tet_count, 2);
    CHECK_EQUAL(out.point_count, 5);
    pbw_tets_free(&out);
    how.target = 61;
    CHECK_EQUAL(pbw_improve(&in, &how, &options, &out, NULL), PBW_ERROR_ARGUMENT);
    memcpy(bad, x, sizeof bad);
    bad[4] = HUGE_VAL;
    in.points = bad;
    CHECK_EQUAL(pbw_improve(&in, NULL, &options, &out, NULL), PBW_ERROR_NOT_FINITE);
    CHECK(out.points == NULL && out.tet_count == 0);
    CHECK_EQUAL(pbw_improve(&in, NULL, &options, NULL, NULL), PBW_ERROR_ARGUMENT);
    test_end();
}

/* A ball of two regions with patches outside and inside, and edges that stay; sizes that need more of both. */
enum { LABELLED = 60 };

typedef struct labelled {
    double *x, sizes[LABELLED];
    pbw_mesh mesh;
    pbw_index *patches, *regions, edges[2 * LABELLED];
    pbw_tets in;
    pbw_improve_options how;
} labelled;

static void label(labelled *l)
{
    size_t i, k;
    memset(l, 0, sizeof *l);
    l->x = ball_points(LABELLED, 0);
    CHECK_EQUAL(pbw_triangulate(3, l->x, NULL, LABELLED, NULL, &l->mesh), PBW_OK);
    l->in = view(&l->mesh);
    l->patches = (pbw_index *)take(l->in.tet_count * 4 * sizeof(pbw_index));
    l->regions = (pbw_index *)take(l->in.tet_count * sizeof(pbw_index));
    for (i = 0; i < 4 * l->in.tet_count; i++) {
        const pbw_index *c = l->in.corners + i / 4 * 4;
        const size_t ids = (size_t)c[0] + c[1] + c[2] + c[3] - c[i % 4];
        l->patches[i] = l->mesh.neighbors[i] == PBW_NONE ? (pbw_index)(ids % 2) : ids % 9 == 0 ? 5 : PBW_NONE;
        l->regions[i / 4] = l->x[3 * (size_t)c[0]] > 0;
    }
    for (i = 0; i < LABELLED; i++) {
        l->sizes[i] = 0.8;
        for (k = 0; k < 2; k++) {
            l->edges[2 * i + k] = l->in.corners[4 * (i % 20) + k];             /* some twice */
        }
    }
    l->in.patches = l->patches;
    l->in.regions = l->regions;
    l->in.edges = l->edges;
    l->in.edge_count = LABELLED;
    l->how.sizes = l->sizes;
    l->how.rounds = 1;
    l->how.passes = 1;
}

static void label_free(labelled *l)
{
    pbw_free(&l->mesh);
    free(l->x);
    free(l->patches);
    free(l->regions);
}

/* Two balls that have one point in common, of several blocks that threads improve at once: the bytes do not depend on
   threads.  1 % of the input's tetrahedra have a least angle below report.before.percent. */
static void test_blocks(void)
{
    static const int threads[3] = { 2, 3, 8 };
    const size_t count = 1600;
    double *x = ball_points(2 * count, 0);
    pbw_options options;
    pbw_improve_options how;
    pbw_improve_report report, other;
    pbw_mesh mesh;
    pbw_tets in, out, again;
    pbw_index *corners;
    size_t i, below = 0;
    if (!test_begin("blocks on several threads")) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&options, 0, sizeof options);
    memset(&how, 0, sizeof how);
    how.passes = 4;
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, count, NULL, &mesh), PBW_OK);
    corners = (pbw_index *)take(32 * mesh.simplex_count);
    for (i = 0; i < 3 * count; i++) {                /* point 0 is on the sphere; the other ball is across from it */
        x[3 * count + i] = 2 * x[i % 3] - x[i];
    }
    for (i = 0; i < 4 * mesh.simplex_count; i++) {
        const pbw_index p = mesh.simplices[i];
        corners[i] = p;
        corners[4 * mesh.simplex_count + i] = p == 0 ? 0 : p + (pbw_index)count;
    }
    in = view(&mesh);
    in.point_count = 2 * count;
    in.points = x;
    in.corners = corners;
    in.tet_count = 2 * mesh.simplex_count;
    options.threads = 1;
    CHECK_EQUAL(pbw_improve(&in, &how, &options, &out, &report), PBW_OK);
    CHECK(is_sound(&out) && report.after.least_sine >= report.before.least_sine);
    for (i = 0; i < in.tet_count; i++) {
        const pbw_index *c = corners + 4 * i;
        below += pbw_tet_measure(PBW_MEASURE_LEAST_DIHEDRAL, x + 3 * (size_t)c[0], x + 3 * (size_t)c[1],
                                 x + 3 * (size_t)c[2], x + 3 * (size_t)c[3]) < report.before.percent * (1 - 1e-9);
    }
    CHECK(below <= in.tet_count / 100 && below + 2 >= in.tet_count / 100);           /* each angle is there twice */
    test_say("%zu tetrahedra, %zu below 30 degrees, then %zu", in.tet_count, report.before.below[3], report.left);
    CHECK(report.left * 10 < report.before.below[3]);
    for (i = 0; i < 3; i++) {
        options.threads = threads[i];
        CHECK_EQUAL(pbw_improve(&in, &how, &options, &again, &other), PBW_OK);
        CHECK(same_bytes(&again, &out) && memcmp(&other, &report, sizeof other) == 0);
        pbw_tets_free(&again);
    }
    pbw_tets_free(&out);
    pbw_free(&mesh);
    free(corners);
    free(x);
    test_end();
}

/* New memory is all ones: as doubles, no numbers. */
static void *resize_to_ones(void *user, void *ptr, size_t old_size, size_t new_size)
{
    char *block = new_size > 0 ? (char *)malloc(new_size) : NULL;
    (void)user;
    if (block != NULL) {
        memset(block, 0xff, new_size);
        memcpy(block, ptr != NULL ? ptr : block, ptr == NULL ? 0 : old_size < new_size ? old_size : new_size);
    }
    if (block != NULL || new_size == 0) {
        free(ptr);
    }
    return block;
}

/* A mesh that gets its first blocks after points were inserted, in a frozen surface: places are numbers. */
static void test_growth(void)
{
    const size_t count = 1500;
    double *x = ball_points(count, 0);
    unsigned char marks[1500] = { 0 };
    pbw_options options;
    pbw_improve_options how;
    pbw_improve_report report;
    pbw_mesh mesh;
    pbw_tets in, out;
    size_t i;
    if (!test_begin("growth in a frozen surface")) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&options, 0, sizeof options);
    memset(&how, 0, sizeof how);
    how.passes = 5;
    how.target = 40;
    options.resize = resize_to_ones;
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, count, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    for (i = 0; i < count; i++) {
        marks[i] = i % 2 == 0 ? PBW_TETS_FROZEN : PBW_TETS_FOUND;
    }
    in.marks = marks;
    CHECK_EQUAL(pbw_improve(&in, &how, &options, &out, &report), PBW_OK);
    CHECK(is_sound(&out) && report.insertions > 600);
    test_say("%zu to %zu tetrahedra, %zu insertions", in.tet_count, out.tet_count, report.insertions);
    pbw_tets_free(&out);
    pbw_free(&mesh);
    free(x);
    test_end();
}

/* Patches and edges: the same bytes for any number of threads, after each allocation that fails, and at 30 levels of
   options.memory_limit, of which a call holds no more. */
static void test_labelled(void)
{
    static const int threads[2] = { 2, 5 };
    labelled l;
    pbw_options options;
    pbw_tets out, other;
    meter m;
    size_t most, enough, i;
    long k, requests;
    if (!test_begin("patches and edges: threads, failing allocations, memory limits")) {
        return;
    }
    label(&l);
    memset(&options, 0, sizeof options);
    options.threads = 1;
    CHECK_EQUAL(pbw_improve(&l.in, &l.how, &options, &out, NULL), PBW_OK);
    CHECK(is_sound(&out) && out.patches != NULL);
    test_say("%zu tetrahedra, %zu edges", out.tet_count, out.edge_count);
    for (i = 0; i < 2; i++) {
        options.threads = threads[i];
        CHECK_EQUAL(pbw_improve(&l.in, &l.how, &options, &other, NULL), PBW_OK);
        CHECK(same_bytes(&out, &other));
        pbw_tets_free(&other);
    }
    options.resize = meter_resize;
    options.resize_user = &m;
    options.threads = 1;
    meter_start(&m, 0, 0);
    CHECK_EQUAL(pbw_improve(&l.in, &l.how, &options, &other, NULL), PBW_OK);
    requests = m.requests;
    pbw_tets_free(&other);
    for (k = 1; k <= requests; k++) {
        pbw_status status;
        meter_start(&m, k, 0);
        status = pbw_improve(&l.in, &l.how, &options, &other, NULL);
        CHECK(m.refused > 0);
        CHECK(status == PBW_OK ? same_bytes(&out, &other) : status == PBW_ERROR_MEMORY && other.points == NULL);
        pbw_tets_free(&other);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    for (i = 0; i < 2; i++) {
        options.threads = i == 0 ? 1 : 3;
        options.memory_limit = 0;
        meter_start(&m, 0, 0);
        CHECK_EQUAL(pbw_improve(&l.in, &l.how, &options, &other, NULL), PBW_OK);
        most = m.peak;
        pbw_tets_free(&other);
        for (k = 1, enough = 0; k <= 30; k += 1 + 2 * (long)i) {             /* to 1.5 times what it holds without */
            pbw_status status;
            options.memory_limit = most * (size_t)k / 20;
            meter_start(&m, 0, 0);
            status = pbw_improve(&l.in, &l.how, &options, &other, NULL);
            CHECK(status == PBW_OK ? same_bytes(&out, &other) : status == PBW_ERROR_MEMORY);
            if (!CHECK(m.peak <= options.memory_limit)) {
                test_say("%.3f of the limit", (double)m.peak / (double)options.memory_limit);
            }
            enough += status == PBW_OK;
            pbw_tets_free(&other);
            CHECK(m.blocks == 0 && m.faults == 0);
        }
        test_say("holds %zu bytes in %ld requests; %zu of 30 limits suffice", most, requests, enough);
        CHECK(enough >= 3 && enough < 15);
    }
    pbw_tets_free(&out);
    label_free(&l);
    test_end();
}

/* Every allocation fails in turn; and each tenth call of progress cancels. */
static void test_failures(void)
{
    const size_t count = 120;
    double *x = ball_points(count, 0), sizes[120];
    pbw_options options;
    pbw_mesh mesh;
    pbw_tets in, out;
    pbw_status status = PBW_ERROR_MEMORY;
    pbw_improve_options how;
    meter m;
    watch w;
    long k;
    if (!test_begin("failing allocations, limits, cancelling")) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&options, 0, sizeof options);
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, count, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    memset(&how, 0, sizeof how);
    how.rounds = 2;
    how.sizes = sizes;
    for (k = 0; k < 120; k++) {
        sizes[k] = 0.5;
    }
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &m;
    for (k = 1; status == PBW_ERROR_MEMORY && k < 1000; k++) {
        meter_start(&m, k, 1);
        status = pbw_improve(&in, &how, &options, &out, NULL);
        CHECK(status == PBW_ERROR_MEMORY || m.refused <= 2);          /* only sorting the angles may fail quietly */
        pbw_tets_free(&out);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    CHECK(k > 20 && status == PBW_OK);
    meter_start(&m, 0, 0);
    options.memory_limit = 50000;
    CHECK_EQUAL(pbw_improve(&in, NULL, &options, &out, NULL), PBW_ERROR_MEMORY);
    CHECK(m.blocks == 0 && m.faults == 0 && m.peak <= 50000);
    options.memory_limit = 0;
    options.progress = watch_progress;
    options.progress_user = &w;
    for (k = 1, status = PBW_CANCELLED; status == PBW_CANCELLED && k < 1000; k += 9) {
        watch_start(&w, k);
        status = pbw_improve(&in, &how, &options, &out, NULL);
        CHECK(w.wrong == 0);
        CHECK(status == PBW_OK || out.points == NULL);
        pbw_tets_free(&out);
        CHECK(m.blocks == 0);
    }
    CHECK(k > 10 && status == PBW_OK);
    pbw_free(&mesh);
    free(x);
    test_end();
}

typedef struct asking {                    /* projections since the last question whether to go on; the most of them */
    watch watch;
    long since, most, all;
} asking;

static void project_counted(void *user, double p[3])
{
    asking *a = (asking *)user;
    const double length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    int k;
    a->since++;
    for (k = 0; k < 3 && length > 0; k++) {
        p[k] /= length;
    }
}

static int ask_counted(void *user, pbw_stage stage, double done)
{
    asking *a = (asking *)user;
    a->most = a->since > a->most ? a->since : a->most;
    a->all += a->since;
    a->since = 0;
    return watch_progress(&a->watch, stage, done);
}

/* A block asks whether to go on after so much work, however many tetrahedra are bad in it; and it can end there. */
static void test_questions(void)
{
    const size_t count = 1000;
    const long leg = PBWIM__LEG / PBWIM__PROJECTION, tet = 34 * 40 * 8;      /* climbs, their steps, directions */
    double *x = ball_points(count, 1);
    pbw_options options;
    pbw_improve_options how;
    pbw_mesh mesh;
    pbw_tets in, out;
    asking a;
    meter m;
    long calls, k;
    if (!test_begin("questions within blocks")) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&options, 0, sizeof options);
    memset(&how, 0, sizeof how);
    memset(&a, 0, sizeof a);
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, count, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    how.passes = 1;
    how.project = project_counted;
    how.project_user = &a;
    options.threads = 1;
    options.progress = ask_counted;
    options.progress_user = &a;
    options.resize = meter_resize;
    options.resize_user = &m;
    meter_start(&m, 0, 0);
    watch_start(&a.watch, 0);
    CHECK_EQUAL(pbw_improve(&in, &how, &options, &out, NULL), PBW_OK);
    test_say("%ld projections, %ld questions, at most %ld between two", a.all, a.watch.calls, a.most);
    CHECK(a.watch.wrong == 0 && a.all > 2 * (leg + tet) && a.most <= leg + tet);
    pbw_tets_free(&out);
    for (calls = a.watch.calls, k = 1; k < 4; k++) {
        watch_start(&a.watch, calls * k / 4);
        CHECK_EQUAL(pbw_improve(&in, &how, &options, &out, NULL), PBW_CANCELLED);
        CHECK(a.watch.calls == calls * k / 4 && out.memory == NULL && m.blocks == 0 && m.faults == 0);
    }
    pbw_free(&mesh);
    free(x);
    test_end();
}

/* Setting up gives signs, and counts in the budget: when that is over by then, there is no pass. */
static void test_budget(void)
{
    const size_t count = 300;
    double *x = ball_points(count, 0);
    pbw_options options;
    pbw_improve_options how;
    pbw_improve_report r;
    pbw_mesh mesh;
    pbw_tets in, out;
    watch w;
    if (!test_begin("a budget that is over when work begins")) {
        free(x);
        return;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&options, 0, sizeof options);
    memset(&how, 0, sizeof how);
    CHECK_EQUAL(pbw_triangulate(3, x, NULL, count, NULL, &mesh), PBW_OK);
    in = view(&mesh);
    how.seconds = 1e-9;
    options.progress = watch_progress;
    options.progress_user = &w;
    watch_start(&w, 0);
    CHECK_EQUAL(pbw_improve(&in, &how, &options, &out, &r), PBW_OK);
    CHECK(r.passes == 0 && r.left > 0 && out.tet_count == in.tet_count && w.wrong == 0);
    CHECK(memcmp(&r.before, &r.after, sizeof r.before) == 0 && r.after.bins[0] > 0);
    CHECK(w.calls >= 4);
    pbw_tets_free(&out);
    pbw_free(&mesh);
    free(x);
    test_end();
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 1);
    test_measures();
    test_spread();
    test_budget();
    test_surface(0);
    test_surface(1);
    test_cube(0);
    test_cube(1);
    test_ball();
    test_distance();
    test_regions();
    test_frozen(PBW_TETS_FIXED, 0, 0);
    test_frozen(PBW_TETS_FROZEN, 0, 0);
    test_frozen(PBW_TETS_FROZEN, 0.5, 0);
    test_frozen(PBW_TETS_FROZEN, 0, 1);
    test_reserved();
    test_smoothers(PBW_SMOOTHER_ODT);
    test_smoothers(PBW_SMOOTHER_LLOYD);
    test_smoothers(PBW_SMOOTHER_LAPLACIAN);
    test_aims();
    test_sizes(0);
    test_sizes(3);
    test_transfer();
    test_refused();
    test_failures();
    test_questions();
    test_labelled();
    test_blocks();
    test_growth();
    return test_finish();
}
