/* test_adapt2.c: pbw_adapt2.h: measures against closed forms, smoothing, adaptation and transfer, each mesh by the
   exact check of planes.h. */
#include "pbw.h"
#include "../examples/lib/pbw_mesh2.h"
#include "../examples/lib/pbw_adapt2.h"
#include "inputs.h"
#include "meter.h"
#include "planes.h"
#include "test.h"
#include "watch.h"

/* A plate of 10 by 6 with a hole, a wall inside, and a slit that ends inside; regions 3 and 5 of the caller. */
static const double plate_points[] = { 0, 0, 10, 0, 10, 6, 0, 6, 2, 2, 3, 2, 3, 3, 2, 3, 5, 0, 5, 6, 7, 2, 8.3, 3.1 };
static const pbw_index plate_segments[] = { 0, 8, 8, 1, 1, 2, 2, 9, 9, 3, 3, 0, 4, 5, 5, 6, 6, 7, 7, 4, 8, 9,
                                            10, 11 };
static const pbw_index plate_ids[] = { 20, 20, 21, 22, 22, 23, 24, 24, 24, 24, 25, 26 };
static const double plate_holes[] = { 2.5, 2.5 };
static const pbw_plane_region plate_regions[] = { { 9, 5, 0 }, { 1, 1, 0 } };
enum { PLATE_POINTS = 12, PLATE_SEGMENTS = 12 };

static void check_plane(const pbw_plane *plane)
{
    const char *fault = planes_fault(plane, NULL, 0, 0);
    if (!CHECK(fault == NULL)) {
        test_say("%s", fault);
    }
}

static pbw_status plate_with(double size, const pbw_options *build, pbw_plane *plane)
{
    pbw_plane_input input;
    pbw_plane_options options;
    memset(&input, 0, sizeof input);
    memset(&options, 0, sizeof options);
    input.points = plate_points;
    input.point_count = PLATE_POINTS;
    input.segments = plate_segments;
    input.segment_ids = plate_ids;
    input.segment_count = PLATE_SEGMENTS;
    input.holes = plate_holes;
    input.hole_count = 1;
    input.regions = plate_regions;
    input.region_count = 2;
    options.rule = PBW_PLANE_SEEDS;
    options.flags = PBW_PLANE_REFINE;
    options.size = size;
    options.build = build;
    return pbw_plane_make(&input, &options, plane);
}

/* The length of all edges with a number, and whether it and the regions are those of the plate. */
static void check_plate(const pbw_plane *plane)
{
    static const double lengths[] = { 10, 6, 10, 6, 4, 6, 1.7029386365926402 };
    double length[7] = { 0, 0, 0, 0, 0, 0, 0 }, area[2] = { 0, 0 };
    size_t i, k;
    for (i = 0; i < plane->edge_count; i++) {
        for (k = plane->edge_first[i]; k < plane->edge_first[i + 1]; k++) {
            const double *a = planes_at(plane->points, plane->edges[2 * i]);
            const double *b = planes_at(plane->points, plane->edges[2 * i + 1]);
            if (CHECK(plane->edge_segments[k] >= 20 && plane->edge_segments[k] < 27)) {
                length[plane->edge_segments[k] - 20] += hypot(a[0] - b[0], a[1] - b[1]);
            }
        }
    }
    for (i = 0; i < 7; i++) {
        CHECK(fabs(length[i] - lengths[i]) < 1e-9);
    }
    CHECK(plane->region_count == 2);
    for (i = 0; i < plane->triangle_count; i++) {
        const pbw_index *v = plane->triangles + 3 * i, seed = plane->region_seeds[plane->regions[i]];
        if (CHECK(seed < 2)) {
            area[seed] += pbw_plane_measure_of(PBW_PLANE_AREA, planes_at(plane->points, v[0]),
                                               planes_at(plane->points, v[1]), planes_at(plane->points, v[2]));
        }
    }
    CHECK(fabs(area[0] - 30) < 1e-9 && fabs(area[1] - 29) < 1e-9);
    check_plane(plane);
}

static double *new_doubles(size_t count)
{
    double *x = (double *)calloc(count + 1, sizeof *x);
    if (x == NULL) {
        exit(2);
    }
    return x;
}

/* ---- tests */

static void test_measures(void)
{
    static const double equal[] = { 0, 0, 2, 0, 1, 1.7320508075688772 }, right[] = { 0, 0, 3, 0, 0, 4 };
    /* of the right triangle 3 4 5: r = 1, R = 2.5, area 6 */
    static const double of_equal[] = { 60, 60, 1, 1, 1, 1, 1, 1, 1, 1.7320508075688772 };
    static const double of_right[] = { 36.86989764584402, 90, 0.8, 1.25, 1.4433756729740643, 1.6666666666666667,
                                       0.83138438763306111, 1.2028130608117204, 0.69282032302755092, 6 };
    static const double flat[] = { 0, 0, 1, 0, 3, 0 };
    int m;
    if (test_begin("measures of quality")) {
        for (m = 0; m < PBW_PLANE_MEASURES; m++) {
            const pbw_plane_measure one = (pbw_plane_measure)m;
            CHECK(fabs(pbw_plane_measure_of(one, equal, equal + 2, equal + 4) - of_equal[m]) < 1e-13 * 60);
            CHECK(fabs(pbw_plane_measure_of(one, right, right + 2, right + 4) - of_right[m]) < 1e-13 * 60);
            CHECK(fabs(pbw_plane_measure_of(one, right + 2, right + 4, right) - of_right[m]) < 1e-13 * 60);
            CHECK(strlen(pbw_plane_measure_name(one)) > 3);
        }
        CHECK(pbw_plane_measure_of(PBW_PLANE_MIN_ANGLE, flat, flat + 2, flat + 4) <= 0);
        CHECK(pbw_plane_measure_of(PBW_PLANE_SHAPE, flat, flat + 2, flat + 4) <= 0);
        CHECK(pbw_plane_measure_of(PBW_PLANE_CONDITION, flat, flat + 2, flat + 4) > 1e300);
        test_end();
    }
    if (test_begin("histogram")) {
        pbw_plane plane;
        pbw_plane_quality q;
        size_t sum = 0;
        CHECK_EQUAL(plate_with(0.5, NULL, &plane), PBW_OK);
        for (m = 0; m < PBW_PLANE_MEASURES; m++) {
            int b;
            q = pbw_plane_quality_of(&plane, (pbw_plane_measure)m);
            for (sum = 0, b = 0; b < PBW_PLANE_BINS; b++) {
                sum += q.bins[b];
            }
            CHECK(sum == plane.triangle_count && q.least <= q.mean && q.mean <= q.most && q.least < q.most);
        }
        q = pbw_plane_quality_of(&plane, PBW_PLANE_MIN_ANGLE);
        CHECK(q.least >= 30 - 1e-9 && q.most <= 60 && q.bins[9] == 0 && q.bins[PBW_PLANE_BINS - 1] > 0);
        pbw_plane_free(&plane);
        test_end();
    }
}

static void test_smoothing(void)
{
    static const char *const names[] = { "Laplace", "Lloyd", "ODT" };
    int way;
    for (way = PBW_PLANE_LAPLACE; way <= PBW_PLANE_ODT; way++) {
        if (test_begin("smoothing: %s", names[way])) {
            pbw_plane plane, before;
            pbw_plane_quality old, now;
            size_t i, moved = 0;
            CHECK_EQUAL(plate_with(0.4, NULL, &plane), PBW_OK);
            CHECK_EQUAL(plate_with(0.4, NULL, &before), PBW_OK);
            old = pbw_plane_quality_of(&plane, PBW_PLANE_MIN_ANGLE);
            CHECK_EQUAL(pbw_plane_smooth(&plane, (pbw_plane_way)way, 5, NULL, NULL), PBW_OK);
            now = pbw_plane_quality_of(&plane, PBW_PLANE_MIN_ANGLE);
            test_say("least angle %.2f to %.2f, mean %.2f to %.2f", old.least, now.least, old.mean, now.mean);
            CHECK(now.least >= old.least - 1e-9 && now.mean > old.mean + 1);
            CHECK(plane.point_count == before.point_count && plane.input_count == before.input_count);
            for (i = 0; i < plane.edge_count; i++) {                 /* they stay, bit for bit */
                const pbw_index v = plane.edges[2 * i];
                CHECK(planes_same(planes_at(plane.points, v), planes_at(before.points, v)));
            }
            for (i = 0; i < plane.point_count; i++) {
                moved += !planes_same(plane.points + 2 * i, before.points + 2 * i);
            }
            CHECK(2 * moved > plane.point_count && plane.edge_count == before.edge_count);
            check_plate(&plane);
            pbw_plane_free(&plane);
            pbw_plane_free(&before);
            test_end();
        }
    }
}

static void fill_sizes(const pbw_plane *plane, int round, double *sizes)
{
    size_t i;
    for (i = 0; i < plane->point_count; i++) {       /* fine at a place that moves */
        const double x = plane->points[2 * i] - 2.5 * round, y = plane->points[2 * i + 1] - 5;
        sizes[i] = 0.06 + 0.3 * sqrt(x * x + y * y);
    }
}

static void test_adaptation(void)
{
    pbw_plane plane, next;
    size_t i;
    int round;
    if (test_begin("adaptation: a fine place that moves")) {
        size_t counts[5] = { 0 };
        CHECK_EQUAL(plate_with(0.5, NULL, &plane), PBW_OK);
        for (round = 0; round < 5; round++) {
            double *sizes = new_doubles(plane.point_count), *x = new_doubles(2 * plane.point_count), *y;
            pbw_index *from = (pbw_index *)new_doubles(plane.point_count);
            fill_sizes(&plane, round, sizes);
            CHECK_EQUAL(pbw_plane_adapt(&plane, sizes, NULL, NULL, &next, from), PBW_OK);
            check_plate(&next);
            y = new_doubles(2 * next.point_count);
            for (i = 0; i < plane.point_count; i++) {
                x[2 * i] = 1 + 3 * plane.points[2 * i] - plane.points[2 * i + 1];
                x[2 * i + 1] = (double)i;
            }
            CHECK_EQUAL(pbw_plane_transfer(&plane, &next, x, 2, y, NULL), PBW_OK);
            for (i = 0; i < next.point_count; i++) {
                CHECK(fabs(y[2 * i] - (1 + 3 * next.points[2 * i] - next.points[2 * i + 1])) < 1e-12);
                CHECK(i >= next.input_count || y[2 * i + 1] == (double)from[i]);
                CHECK(i >= next.input_count || planes_same(next.points + 2 * i, planes_at(plane.points, from[i])));
            }
            counts[round] = next.triangle_count;
            free(sizes);
            free(x);
            free(y);
            free(from);
            pbw_plane_free(&plane);
            plane = next;
        }
        test_say("%lu, %lu, %lu, %lu, %lu triangles", (unsigned long)counts[0], (unsigned long)counts[1],
                 (unsigned long)counts[2], (unsigned long)counts[3], (unsigned long)counts[4]);
        CHECK(counts[4] < 2 * counts[0] && counts[0] > 300);        /* what was fine before is coarse again */
        pbw_plane_free(&plane);
        test_end();
    }
    if (test_begin("adaptation: coarse again, but what is kept")) {
        double *sizes;
        unsigned char *keep;
        CHECK_EQUAL(plate_with(0.1, NULL, &plane), PBW_OK);
        sizes = new_doubles(plane.point_count);
        keep = (unsigned char *)new_doubles(plane.point_count);
        CHECK_EQUAL(pbw_plane_adapt(&plane, sizes, NULL, NULL, &next, NULL), PBW_OK);
        check_plate(&next);
        CHECK(20 * next.triangle_count < plane.triangle_count);
        pbw_plane_free(&next);
        memset(keep, 1, plane.point_count);
        CHECK_EQUAL(pbw_plane_adapt(&plane, sizes, keep, NULL, &next, NULL), PBW_OK);
        CHECK(planes_hash(&next) == planes_hash(&plane));
        pbw_plane_free(&next);
        pbw_plane_free(&plane);
        free(sizes);
        free(keep);
        test_end();
    }
    if (test_begin("adaptation: sizes grow from the only one given")) {
        size_t around = 0, left = 0;
        double *sizes;
        const double *at;
        pbw_index *from;
        CHECK_EQUAL(plate_with(0.1, NULL, &plane), PBW_OK);
        sizes = new_doubles(plane.point_count);
        from = (pbw_index *)new_doubles(plane.point_count);
        at = plane.points + 2 * (plane.point_count - 1);
        sizes[plane.point_count - 1] = 0.05;
        CHECK_EQUAL(pbw_plane_adapt(&plane, sizes, NULL, NULL, &next, from), PBW_OK);
        for (i = 0; i < plane.point_count; i++) {    /* those that are as near have sizes below two edges */
            around += hypot(plane.points[2 * i] - at[0], plane.points[2 * i + 1] - at[1]) < 0.15;
        }
        for (i = 0; i < next.input_count; i++) {
            const double *p = plane.points + 2 * (size_t)from[i];
            left += hypot(p[0] - at[0], p[1] - at[1]) < 0.15;
        }
        test_say("%lu of %lu stay", (unsigned long)left, (unsigned long)around);
        CHECK(left == around && around > 4 && 2 * next.input_count < plane.point_count);
        pbw_plane_free(&next);
        pbw_plane_free(&plane);
        free(sizes);
        free(from);
        test_end();
    }
    if (test_begin("sizes from errors")) {
        double *error, *sizes;
        CHECK_EQUAL(plate_with(0.3, NULL, &plane), PBW_OK);
        error = new_doubles(plane.triangle_count);
        sizes = new_doubles(plane.point_count);
        for (i = 0; i < plane.triangle_count; i++) {
            error[i] = 1;
        }
        pbw_plane_sizes(&plane, error, 4 * plane.triangle_count, sizes);
        CHECK_EQUAL(pbw_plane_adapt(&plane, sizes, NULL, NULL, &next, NULL), PBW_OK);
        CHECK(next.triangle_count > 2 * plane.triangle_count && next.triangle_count < 8 * plane.triangle_count);
        pbw_plane_free(&next);
        pbw_plane_free(&plane);
        free(error);
        free(sizes);
        test_end();
    }
}

/* ---- planes from triangles */

/* A mesh with what it carries. */
typedef struct carrier {
    pbw_plane_input input;
    const pbw_index *triangles, *regions;
    size_t count;
} carrier;

static carrier new_carrier(const double *points, size_t n, const pbw_index *triangles, size_t count,
                           const pbw_index *regions)
{
    carrier c;
    memset(&c, 0, sizeof c);
    c.input.points = points;
    c.input.point_count = n;
    c.triangles = triangles;
    c.regions = regions;
    c.count = count;
    return c;
}

static pbw_status make_carrier(const carrier *c, const pbw_plane_options *options, pbw_plane *plane)
{
    return pbw_plane_from_triangles(&c->input, c->triangles, c->regions, c->count, options, plane);
}

static long double area_of(const double *points, const pbw_index *v)
{
    const double *a = planes_at(points, v[0]), *b = planes_at(points, v[1]), *c = planes_at(points, v[2]);
    return (((long double)b[0] - a[0]) * ((long double)c[1] - a[1])
            - ((long double)b[1] - a[1]) * ((long double)c[0] - a[0])) / 2;
}

/* Whether a region has its area of the input, and a number of segments the length that these have. */
static void check_region(const carrier *c, const pbw_plane *plane, pbw_index region)
{
    long double given = 0, made = 0;
    size_t i;
    for (i = 0; i < c->count; i++) {
        if (c->regions == NULL || c->regions[i] == region) {
            given += fabsl(area_of(c->input.points, c->triangles + 3 * i));
        }
    }
    for (i = 0; i < plane->triangle_count; i++) {
        if (plane->region_seeds[plane->regions[i]] == region) {
            made += area_of(plane->points, plane->triangles + 3 * i);
        }
    }
    if (!CHECK(fabsl(given - made) <= 1e-11L * given)) {
        test_say("region %lu: area %.9Lg for %.9Lg", (unsigned long)region, made, given);
    }
}

static double length_of(const double *points, const pbw_index *ends)
{
    const double *a = planes_at(points, ends[0]), *b = planes_at(points, ends[1]);
    return hypot(a[0] - b[0], a[1] - b[1]);
}

static void check_segments(const carrier *c, const pbw_plane *plane, pbw_index id)
{
    double given = 0, made = 0;
    size_t i, k;
    for (i = 0; i < c->input.segment_count; i++) {
        given += c->input.segment_ids[i] == id ? length_of(c->input.points, c->input.segments + 2 * i) : 0;
    }
    for (i = 0; i < plane->edge_count; i++) {
        for (k = plane->edge_first[i]; k < plane->edge_first[i + 1]; k++) {
            made += plane->edge_segments[k] == id ? length_of(plane->points, plane->edges + 2 * i) : 0;
        }
    }
    if (!CHECK(given > 0 && fabs(given - made) <= 1e-9 * given)) {
        test_say("segments %lu: length %g for %g", (unsigned long)id, made, given);
    }
}

static void check_carried(const carrier *c, const pbw_plane *plane)
{
    size_t i;
    for (i = 0; i < c->count; i++) {
        if (i == 0 || (c->regions != NULL && c->regions[i] != c->regions[i - 1])) {
            check_region(c, plane, c->regions != NULL ? c->regions[i] : PBW_NONE);
        }
    }
    for (i = 0; i < c->input.segment_count; i++) {
        if (i == 0 || c->input.segment_ids[i] != c->input.segment_ids[i - 1]) {
            check_segments(c, plane, c->input.segment_ids[i]);
        }
    }
    check_plane(plane);
}

/* The plane as it is, smoothed; refined; with fewer points again: regions and segments are those of the mesh. */
static void carry_on(const carrier *c, size_t regions)
{
    pbw_plane_options options;
    pbw_plane plane, next;
    double *sizes;
    size_t i;
    memset(&options, 0, sizeof options);
    if (!CHECK_EQUAL(make_carrier(c, NULL, &plane), PBW_OK)) {
        test_say("%s", plane.what);
        return;
    }
    CHECK_EQUAL(plane.region_count, regions);
    check_carried(c, &plane);
    CHECK_EQUAL(pbw_plane_smooth(&plane, PBW_PLANE_ODT, 3, NULL, NULL), PBW_OK);
    check_carried(c, &plane);
    pbw_plane_free(&plane);
    options.flags = PBW_PLANE_REFINE;
    options.angle = 25;
    options.size = 0.3;
    CHECK_EQUAL(make_carrier(c, &options, &plane), PBW_OK);
    CHECK(plane.point_count > c->input.point_count);
    check_carried(c, &plane);
    sizes = new_doubles(plane.point_count);
    for (i = 0; i < plane.point_count; i++) {
        sizes[i] = 2;
    }
    options.angle = -1;
    options.size = 0;
    CHECK_EQUAL(pbw_plane_adapt(&plane, sizes, NULL, &options, &next, NULL), PBW_OK);
    CHECK(next.point_count < plane.point_count);
    check_carried(c, &next);
    free(sizes);
    pbw_plane_free(&plane);
    pbw_plane_free(&next);
}

/* Triangles of random points, some turned; regions are stripes and a spot, segments edges of some triangles. */
static void carry_random(uint64_t seed)
{
    enum { POINTS = 300, NUMBERS = 5 };
    static const pbw_index numbers[NUMBERS] = { 7, 4000000000u, 0, PBW_NONE, 12 };
    uint64_t state = seed;
    double *points = new_doubles(2 * POINTS);
    pbw_index *triangles, *regions, *segments, ids[12];
    pbw_mesh mesh;
    carrier c;
    size_t i, k;
    for (i = 0; i < 2 * POINTS; i++) {
        points[i] = 4 * input_uniform(&state);
    }
    memset(&mesh, 0, sizeof mesh);
    CHECK_EQUAL(pbw_triangulate(2, points, NULL, POINTS, NULL, &mesh), PBW_OK);
    triangles = (pbw_index *)malloc(3 * mesh.simplex_count * sizeof *triangles);
    regions = (pbw_index *)malloc(mesh.simplex_count * sizeof *regions);
    segments = (pbw_index *)malloc(24 * sizeof *segments);
    for (i = 0; i < mesh.simplex_count; i++) {
        const pbw_index *v = mesh.simplices + 3 * i;
        const double x = points[2 * v[0]], y = points[2 * v[0] + 1];
        const int turned = i % 3 == 0;
        regions[i] = numbers[hypot(x - 2, y - 2) < 0.7 ? 3 : x < 1 ? 0 : x < 3 ? 1 : y < 2 ? 2 : 4];
        for (k = 0; k < 3; k++) {
            triangles[3 * i + k] = v[turned ? 2 - k : k];
        }
        if (i < 12) {
            memcpy(segments + 2 * i, v, 2 * sizeof *v);
            ids[i] = (pbw_index)(i < 6 ? 1 : PBW_NONE - 1);
        }
    }
    c = new_carrier(points, POINTS, triangles, mesh.simplex_count, regions);
    c.input.segments = segments;
    c.input.segment_ids = ids;
    c.input.segment_count = 12;
    {   /* how many parts the regions have */
        pbw_plane plane;
        CHECK_EQUAL(make_carrier(&c, NULL, &plane), PBW_OK);
        carry_on(&c, plane.region_count);
        CHECK(plane.region_count >= NUMBERS);
        pbw_plane_free(&plane);
    }
    pbw_free(&mesh);
    free(points);
    free(triangles);
    free(regions);
    free(segments);
}

static void test_regions(void)
{
    /* 0 1 2 / 3 4 5 / 6 7 8 are a lattice; 9 to 11: an island away from it; 12 is where 7 is */
    static const double points[] = { 0, 0, 1, 0, 2, 0, 0, 1, 1, 1, 2, 1, 0, 2, 1, 2, 2, 2, 4, 0, 5, 0, 4, 1, 1, 2 };
    static const pbw_index squares[] = { 0, 1, 4, 0, 4, 3, 1, 2, 5, 5, 4, 1, 9, 10, 11 };
    static const pbw_index of_squares[] = { 6, 6, 8, 8, 6 };
    static const pbw_index shore[] = { 0, 1, 1, 2, 4, 1, 4, 5 }, shore_ids[] = { 4, 4, 9, 4 };
    static const pbw_index corners[] = { 0, 1, 4, 4, 0, 3, 4, 5, 8, 8, 7, 4 }, of_corners[] = { 1, 1, 1, 1 };
    static const pbw_index slit[] = { 3, 4, 6, 6, 4, 7, 4, 5, 12, 8, 5, 12, 3, 4, 0, 4, 0, 1, 1, 2, 5, 5, 4, 1 };
    static const double ring[] = { 0, 0, 6, 0, 6, 6, 0, 6, 1, 1, 5, 1, 5, 5, 1, 5, 2, 2, 4, 2, 4, 4, 2, 4 };
    static const pbw_index of_ring[] = { 0, 1, 4, 1, 5, 4, 1, 2, 5, 2, 6, 5, 2, 3, 6, 3, 7, 6, 3, 0, 7, 0, 4, 7,
                                         8, 9, 10, 8, 10, 11 };
    static const double beside[] = { 0, 0, 1, 0, 1, 1, 0, 1, 1, 0.5, 2, 0, 2, 1 };
    static const pbw_index of_beside[] = { 0, 1, 2, 0, 2, 3, 1, 5, 4, 4, 5, 6, 6, 2, 4 }, one_two[] = { 1, 1, 2, 2, 2 };
    static const double soup[] = { 0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1, 1, 0, 2, 0, 2, 1, 2, 1, 1, 1, 1, 0 };
    static const pbw_index in_order[] = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11 }, of_soup[] = { 3, 3, 2, 2 };
    /* the middle of the thin triangle is none of its points */
    static const double thin[] = { 0, 0, 1, 1, 0.5, 0.49999999999999994, 1, 0, 0, 1 };
    static const pbw_index thins[] = { 0, 2, 1, 0, 3, 2, 2, 3, 1, 0, 1, 4 }, of_thin[] = { 1, 2, 2, 3 };
    pbw_plane plane;
    carrier c;
    if (test_begin("regions and segments of triangles")) {
        c = new_carrier(points, 12, squares, 5, of_squares);
        c.input.segments = shore;
        c.input.segment_ids = shore_ids;
        c.input.segment_count = 4;
        carry_on(&c, 3);
        c.regions = NULL;
        carry_on(&c, 3);                             /* the segment between the squares is kept */
        test_end();
    }
    if (test_begin("regions that touch at a point")) {
        c = new_carrier(points, 9, corners, 4, of_corners);
        carry_on(&c, 2);
        test_end();
    }
    if (test_begin("regions that touch where one has a point more")) {
        c = new_carrier(beside, 7, of_beside, 5, one_two);
        carry_on(&c, 2);
        c.regions = NULL;
        carry_on(&c, 2);                             /* the border that only one of them has is kept */
        test_end();
    }
    if (test_begin("a slit between doubled points")) {
        c = new_carrier(points, 13, slit, 8, NULL);
        carry_on(&c, 1);
        CHECK_EQUAL(make_carrier(&c, NULL, &plane), PBW_OK);
        CHECK_EQUAL(plane.edge_count, 8 + 1);
        pbw_plane_free(&plane);
        test_end();
    }
    if (test_begin("an island in a hole")) {
        static const pbw_index one[] = { 5, 5, 5, 5, 5, 5, 5, 5, 5, 5 };
        c = new_carrier(ring, 12, of_ring, 10, one);
        carry_on(&c, 2);
        test_end();
    }
    if (test_begin("triangles with corners of their own")) {
        c = new_carrier(soup, 12, in_order, 4, of_soup);
        carry_on(&c, 2);
        CHECK_EQUAL(make_carrier(&c, NULL, &plane), PBW_OK);
        CHECK_EQUAL(plane.edge_count, 7);
        pbw_plane_free(&plane);
        test_end();
    }
    if (test_begin("a region without a double inside")) {
        c = new_carrier(thin, 5, thins, 4, of_thin);
        CHECK_EQUAL(make_carrier(&c, NULL, &plane), PBW_OK);
        check_carried(&c, &plane);
        CHECK_EQUAL(pbw_plane_smooth(&plane, PBW_PLANE_LAPLACE, 2, NULL, NULL), PBW_OK);
        check_carried(&c, &plane);
        pbw_plane_free(&plane);
        test_end();
    }
    if (test_begin("regions of random triangles")) {
        carry_random(test_seed);
        carry_random(test_seed + 1);
        test_end();
    }
    if (test_begin("segments that cross a border")) {
        static const pbw_index across[] = { 0, 5 }, number[] = { 2 };
        c = new_carrier(points, 12, squares, 5, of_squares);
        c.input.segments = across;
        c.input.segment_ids = number;
        c.input.segment_count = 1;
        CHECK_EQUAL(make_carrier(&c, NULL, &plane), PBW_ERROR_ARGUMENT);
        CHECK(strstr(plane.what, "cross at (1, 0.5)") != NULL && plane.crossing_count == 0);
        pbw_plane_free(&plane);
        test_end();
    }
}

static void test_triangles(void)
{
    static const double points[] = { 0, 0, 1, 0, 2, 0, 2, 1, 1, 1, 0, 1, 0.5, 0.5 };
    static const pbw_index mesh[] = { 0, 1, 6, 1, 6, 4, 4, 5, 6, 5, 0, 6, 1, 2, 3, 3, 4, 1 };
    static const pbw_index doubled[] = { 0, 1, 4, 0, 1, 5 }, wrong[] = { 0, 1, 9 }, line[] = { 0, 1, 2 };
    unsigned char keep[7] = { 0, 0, 0, 0, 0, 0, 1 };
    pbw_plane_options options;
    pbw_plane plane, next;
    double sizes[7] = { 0, 0, 0, 0, 0, 0, 0 };
    carrier c = new_carrier(points, 7, mesh, 6, NULL);
    if (test_begin("a plane from triangles")) {
        CHECK_EQUAL(make_carrier(&c, NULL, &plane), PBW_OK);
        CHECK(plane.triangle_count == 6 && plane.edge_count == 6);
        check_plane(&plane);
        memset(&options, 0, sizeof options);
        options.angle = -1;
        CHECK_EQUAL(pbw_plane_adapt(&plane, sizes, NULL, &options, &next, NULL), PBW_OK);
        CHECK(next.edge_count == 4 && fabsl(planes_area(&next) - 4) < 1e-12L);       /* lines are one again */
        pbw_plane_free(&next);
        pbw_plane_free(&plane);
        c.triangles = doubled;
        c.count = 2;
        CHECK_EQUAL(make_carrier(&c, NULL, &plane), PBW_ERROR_ARGUMENT);
        CHECK(strstr(plane.what, "one side of the edge from (0, 0) to (1, 0)") != NULL);
        c.triangles = wrong;
        c.count = 1;
        CHECK_EQUAL(make_carrier(&c, NULL, &plane), PBW_ERROR_ARGUMENT);
        CHECK(strstr(plane.what, "triangle 0 has a corner that is not there") != NULL);
        c.triangles = line;
        CHECK_EQUAL(make_carrier(&c, NULL, &plane), PBW_ERROR_ARGUMENT);
        CHECK(strstr(plane.what, "triangle 0 at (0, 0) is flat") != NULL);
        test_end();
    }
    if (test_begin("points that stay where they are")) {
        double moved[14];
        memcpy(moved, points, sizeof points);
        moved[12] = 0.3;
        c = new_carrier(moved, 7, mesh, 6, NULL);
        CHECK_EQUAL(make_carrier(&c, NULL, &plane), PBW_OK);
        CHECK_EQUAL(pbw_plane_smooth(&plane, PBW_PLANE_LAPLACE, 2, keep, NULL), PBW_OK);
        CHECK(memcmp(plane.points, moved, sizeof moved) == 0);
        CHECK_EQUAL(pbw_plane_smooth(&plane, PBW_PLANE_LAPLACE, 2, NULL, NULL), PBW_OK);
        CHECK(memcmp(plane.points, moved, 12 * sizeof *moved) == 0 && plane.points[12] > 0.3);
        pbw_plane_free(&plane);
        test_end();
    }
}

/* All calls, with memory from a meter.  Returns the first status that is not PBW_OK; *digest: of all results. */
static pbw_status run_all(const pbw_options *build, uint64_t *digest)
{
    pbw_plane plane, next, again;
    pbw_plane_options options;
    double *sizes, *values;
    pbw_status status;
    memset(&options, 0, sizeof options);
    memset(&next, 0, sizeof next);
    memset(&again, 0, sizeof again);
    options.build = build;
    status = plate_with(2, build, &plane);
    sizes = new_doubles(plane.point_count);
    *digest = planes_digest(&plane);
    if (status == PBW_OK) {
        status = pbw_plane_smooth(&plane, PBW_PLANE_LLOYD, 2, NULL, &options);
        CHECK((planes_digest(&plane) == *digest) == (status != PBW_OK));     /* both rounds, or neither */
    }
    status = status == PBW_OK ? pbw_plane_adapt(&plane, sizes, NULL, &options, &next, NULL) : status;
    values = new_doubles(next.point_count);
    status = status == PBW_OK ? pbw_plane_transfer(&plane, &next, sizes, 1, values, &options) : status;
    if (status == PBW_OK) {
        carrier c = new_carrier(plane.points, plane.point_count, plane.triangles, plane.triangle_count,
                                plane.regions);
        c.input.segments = plane.edges;
        c.input.segment_count = plane.edge_count / 2;
        status = make_carrier(&c, &options, &again);
    }
    *digest = planes_mix(planes_digest(&plane), values, next.point_count * sizeof *values);
    *digest += planes_digest(&next) * 3 + planes_digest(&again) * 5;
    free(sizes);
    free(values);
    pbw_plane_free(&plane);
    pbw_plane_free(&next);
    pbw_plane_free(&again);
    return status;
}

/* ---- the memory limit: each public call alone, on inputs without it */

static pbw_status limited_strokes(const pbw_plane_options *options, unsigned flags, uint64_t *digest)
{
    enum { SEGMENTS = 400 };
    double points[4 * SEGMENTS];
    pbw_index segments[2 * SEGMENTS];
    pbw_plane_options own = *options;
    pbw_plane_input input;
    pbw_plane plane;
    pbw_status status;
    uint64_t state = 1;
    int i;
    memset(&input, 0, sizeof input);
    for (i = 0; i < 2 * SEGMENTS; i++) {             /* short ones, some of which cross */
        segments[i] = (pbw_index)i;
        points[2 * i] = i % 2 ? points[2 * i - 2] + 0.1 * input_uniform(&state) : input_uniform(&state);
        points[2 * i + 1] = i % 2 ? points[2 * i - 1] + 0.1 * input_uniform(&state) : input_uniform(&state);
    }
    input.points = points;
    input.segments = segments;
    input.point_count = 2 * SEGMENTS;
    input.segment_count = SEGMENTS;
    own.flags = flags;
    status = pbw_plane_make(&input, &own, &plane);
    *digest = planes_digest(&plane);
    pbw_plane_free(&plane);
    return status;
}

static pbw_status limited_split(const pbw_plane_options *options, uint64_t *digest)
{
    return limited_strokes(options, PBW_PLANE_SPLIT_CROSSINGS, digest);
}

static pbw_status limited_make(const pbw_plane_options *options, uint64_t *digest)
{
    return limited_strokes(options, PBW_PLANE_SPLIT_CROSSINGS | PBW_PLANE_REFINE, digest);
}

static pbw_status limited_rings(const pbw_plane_options *options, uint64_t *digest)
{
    enum { TEETH = 200 };
    static const size_t first[] = { 0, 2 * TEETH };
    double points[4 * TEETH];
    pbw_plane plane;
    pbw_status status;
    int i;
    for (i = 0; i < TEETH; i++) {
        points[2 * i] = points[4 * TEETH - 2 - 2 * i] = i;
        points[2 * i + 1] = i % 2;
        points[4 * TEETH - 1 - 2 * i] = 2 + i % 2;
    }
    status = pbw_plane_rings(points, first, 1, options, &plane);
    *digest = planes_digest(&plane);
    pbw_plane_free(&plane);
    return status;
}

static pbw_status limited_smooth(const pbw_plane_options *options, uint64_t *digest)
{
    pbw_plane plane;
    pbw_status status = plate_with(0.7, NULL, &plane);
    CHECK_EQUAL(status, PBW_OK);
    status = pbw_plane_smooth(&plane, PBW_PLANE_LLOYD, 3, NULL, options);
    *digest = planes_digest(&plane);
    pbw_plane_free(&plane);
    return status;
}

static pbw_status limited_adapt(const pbw_plane_options *options, uint64_t *digest)
{
    pbw_plane plane, next;
    pbw_status status = plate_with(0.7, NULL, &plane);
    double *sizes = new_doubles(plane.point_count);
    CHECK_EQUAL(status, PBW_OK);
    fill_sizes(&plane, 1, sizes);
    status = pbw_plane_adapt(&plane, sizes, NULL, options, &next, NULL);
    *digest = planes_digest(&next);
    pbw_plane_free(&plane);
    pbw_plane_free(&next);
    free(sizes);
    return status;
}

static pbw_status limited_triangles(const pbw_plane_options *options, uint64_t *digest)
{
    pbw_plane plane, next;
    pbw_status status = plate_with(0.7, NULL, &plane);
    carrier c;
    CHECK_EQUAL(status, PBW_OK);
    c = new_carrier(plane.points, plane.point_count, plane.triangles, plane.triangle_count, plane.regions);
    c.input.segments = plane.edges;
    c.input.segment_count = plane.edge_count;
    status = make_carrier(&c, options, &next);
    *digest = planes_digest(&next);
    pbw_plane_free(&plane);
    pbw_plane_free(&next);
    return status;
}

static pbw_status limited_transfer(const pbw_plane_options *options, uint64_t *digest)
{
    pbw_plane plane;
    pbw_status status = plate_with(0.7, NULL, &plane);
    double *values = new_doubles(2 * plane.point_count);
    CHECK_EQUAL(status, PBW_OK);
    fill_sizes(&plane, 1, values);
    status = pbw_plane_transfer(&plane, &plane, values, 1, values + plane.point_count, options);
    *digest = planes_mix(0, values + plane.point_count, plane.point_count * sizeof *values);
    pbw_plane_free(&plane);
    free(values);
    return status;
}

/* At each call of progress; those of smoothing and of values are as many as points ask for. */
static void test_cancel(void)
{
    static const struct { const char *name; pbw_status (*call)(const pbw_plane_options *options, uint64_t *digest);
                          long least; } calls[] = {
        { "smooth", limited_smooth, 3 }, { "adapt", limited_adapt, 2 }, { "triangles", limited_triangles, 2 },
        { "transfer", limited_transfer, 1 }
    };
    size_t i;
    for (i = 0; i < sizeof calls / sizeof *calls; i++) {
        if (test_begin("cancelled at any call: %s", calls[i].name)) {
            pbw_plane_options options;
            pbw_options build;
            pbw_status status = PBW_CANCELLED;
            uint64_t digest;
            watch w;
            long k;
            memset(&options, 0, sizeof options);
            memset(&build, 0, sizeof build);
            options.build = &build;
            build.threads = 1;
            build.progress = watch_progress;
            build.progress_user = &w;
            for (k = 1; status != PBW_OK; k += 1 + k / 4) {
                watch_start(&w, k);
                status = calls[i].call(&options, &digest);
                CHECK(status == PBW_OK || status == PBW_CANCELLED);
            }
            CHECK(k > calls[i].least);
            test_end();
        }
    }
}

static void test_limit(void)
{
    static const struct {
        const char *name;
        pbw_status (*call)(const pbw_plane_options *options, uint64_t *digest);
    } calls[] = {
        { "make, crossings split", limited_split }, { "make, refined", limited_make }, { "rings", limited_rings },
        { "smooth", limited_smooth }, { "adapt", limited_adapt }, { "from triangles", limited_triangles },
        { "transfer", limited_transfer }
    };
    size_t i, k;
    for (i = 0; i < sizeof calls / sizeof *calls; i++) {
        if (test_begin("memory limit: %s", calls[i].name)) {
            pbw_plane_options options;
            pbw_options build;
            uint64_t digest, other;
            meter m;
            size_t most, failed = 0;
            memset(&options, 0, sizeof options);
            memset(&build, 0, sizeof build);
            build.threads = 1;
            build.resize = meter_resize;
            build.resize_user = &m;
            options.build = &build;
            meter_start(&m, 0, 0);
            CHECK_EQUAL(calls[i].call(&options, &digest), PBW_OK);
            most = m.peak;
            for (k = 1; k <= 30; k++) {              /* to 1.5 times what it holds without a limit */
                pbw_status status;
                build.memory_limit = most * k / 20;
                meter_start(&m, 0, 0);
                status = calls[i].call(&options, &other);
                CHECK(status == PBW_OK ? other == digest : status == PBW_ERROR_MEMORY);
                CHECK(m.peak <= build.memory_limit && m.blocks == 0 && m.faults == 0);
                failed += status != PBW_OK;
            }
            test_say("holds %lu bytes; %lu of 30 limits suffice", (unsigned long)most, (unsigned long)(30 - failed));
            CHECK(failed >= 15 && failed < 30);
            test_end();
        }
    }
}

static void test_failures(void)
{
    pbw_plane plane, none;
    pbw_options build;
    double size = 1;
    memset(&none, 0, sizeof none);
    memset(&build, 0, sizeof build);
    if (test_begin("adaptation: arguments")) {
        CHECK_EQUAL(pbw_plane_adapt(&none, &size, NULL, NULL, &plane, NULL), PBW_ERROR_ARGUMENT);
        CHECK(plane.what[0] != 0);
        CHECK_EQUAL(pbw_plane_adapt(NULL, &size, NULL, NULL, NULL, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_plane_smooth(NULL, PBW_PLANE_ODT, 1, NULL, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_plane_smooth(&none, PBW_PLANE_ODT, 1, NULL, NULL), PBW_OK);
        CHECK_EQUAL(pbw_plane_transfer(&none, &none, &size, 1, &size, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_plane_from_triangles(NULL, NULL, NULL, 0, NULL, &plane), PBW_ERROR_ARGUMENT);
        test_end();
    }
    if (test_begin("adaptation: memory")) {
        meter m;
        uint64_t digest, other;
        long k, step, done = 0;                      /* pbw_triangulate can do without some memory */
        build.threads = 1;
        build.resize = meter_resize;
        build.resize_user = &m;
        meter_start(&m, 0, 0);
        CHECK_EQUAL(run_all(&build, &digest), PBW_OK);
        CHECK(m.blocks == 0 && m.faults == 0 && m.requests > 100);
        step = 1 + m.requests / 400;
        for (k = m.requests; k > 0; k -= step) {
            meter_start(&m, k, 0);
            if (run_all(&build, &other) == PBW_OK) {
                CHECK(other == digest);
                done++;
            }
            CHECK(m.blocks == 0 && m.faults == 0);
        }
        CHECK(done < 10);
        test_end();
    }
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 1);
    test_measures();
    test_smoothing();
    test_adaptation();
    test_triangles();
    test_regions();
    test_limit();
    test_cancel();
    test_failures();
    return test_finish();
}
