/* test_mesh2.c: pbw_mesh2.h on the inputs that constrained triangulations and domains break on, by an exact check of
   every mesh, and on random small ones by a slow way as well (planes.h). */
#include "pbw.h"
#include "../examples/lib/pbw_mesh2.h"
#include "domains.h"
#include "meter.h"
#include "meshes.h"
#include "planes.h"
#include "test.h"
#include "watch.h"

#define PI 3.14159265358979323846

/* ---- checks */

static pbw_status make(drawing *d, const pbw_plane_options *options, pbw_plane *plane)
{
    return pbw_plane_make(input_of(d), options, plane);
}

static void check_fault(const char *fault)
{
    if (!CHECK(fault == NULL)) {
        test_say("%s", fault);
    }
}

/* Twice the signed area within the segments. */
static long double shoelace(const drawing *d)
{
    long double sum = 0;
    size_t i;
    for (i = 0; i < d->segment_count; i++) {
        const double *a = d->points + 2 * d->segments[2 * i], *b = d->points + 2 * d->segments[2 * i + 1];
        sum += (long double)a[0] * b[1] - (long double)a[1] * b[0];
    }
    return sum;
}

static void check_area(const pbw_plane *plane, long double twice)
{
    CHECK(fabsl(planes_area(plane) - twice) <= 1e-12L * fabsl(twice));
}

/* Makes the mesh, checks it, and again from points and segments in another order. */
static uint64_t check_drawing(drawing *d, const pbw_plane_options *options)
{
    drawing other;
    pbw_plane plane;
    uint64_t hash = 0, state = 9;
    size_t i, j;
    pbw_index *to;
    if (CHECK_EQUAL(make(d, options, &plane), PBW_OK)) {
        check_fault(planes_fault(&plane, options == NULL || options->rule == PBW_PLANE_HULL ? d->segments : NULL,
                                 d->segment_count, 1));
        hash = planes_hash(&plane);
    }
    pbw_plane_free(&plane);
    memset(&other, 0, sizeof other);
    other.input = d->input;
    to = (pbw_index *)zoo_grow(NULL, (d->point_count + 1) * sizeof *to);
    for (i = 0; i < d->point_count; i++) {
        to[i] = (pbw_index)i;
    }
    for (i = d->point_count; i > 1; i--) {
        const pbw_index swap = to[i - 1];
        j = input_below(&state, (uint32_t)i);
        to[i - 1] = to[j];
        to[j] = swap;
    }
    for (i = 0; i < d->point_count; i++) {
        put(&other, 0, 0);
    }
    for (i = 0; i < d->point_count; i++) {
        memcpy(other.points + 2 * to[i], d->points + 2 * i, 2 * sizeof(double));
    }
    for (i = d->segment_count; i > 0; i--) {
        const pbw_index a = to[d->segments[2 * i - 2]], b = to[d->segments[2 * i - 1]];
        line(&other, a, b);
    }
    if (CHECK_EQUAL(make(&other, options, &plane), PBW_OK)) {
        CHECK(planes_hash(&plane) == hash);
    }
    pbw_plane_free(&plane);
    drawing_free(&other);
    free(to);
    return hash;
}

/* ---- tests */

static void test_constraints(void)
{
    drawing d;
    pbw_plane plane;
    int i, k, n = 40;
    memset(&d, 0, sizeof d);
    if (test_begin("segments through the points of a lattice")) {
        for (i = 0; i < n * n; i++) {
            put(&d, i % n, i / n);
        }
        for (i = 1; i + 1 < n; i += 2) {             /* (0, i) to (n-1, i): all on one line, overlapping */
            line(&d, (pbw_index)(i * n), (pbw_index)(i * n + n - 1));
            line(&d, (pbw_index)(i * n + n - 4), (pbw_index)(i * n + 3));
        }
        check_drawing(&d, NULL);
        CHECK_EQUAL(make(&d, NULL, &plane), PBW_OK);
        for (i = 0, k = 0; i < (int)plane.edge_count; i++) {
            k += plane.edge_first[i + 1] - plane.edge_first[i] == 2;
        }
        CHECK_EQUAL(k, (n / 2 - 1) * (n - 7));
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("a sheared lattice: long segments, all ties")) {
        for (i = 0; i < n * n; i++) {
            put(&d, i % n, i / n + 2 * (i % n));
        }
        for (i = 0; i + 2 < n; i++) {                /* knight's moves */
            line(&d, (pbw_index)(i * n), (pbw_index)((i + 1) * n + n - 1));
        }
        check_drawing(&d, NULL);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("long segments, isolated points, dangling ends")) {
        uint64_t state = 3;
        for (i = 0; i < 20000; i++) {
            put(&d, input_uniform(&state), input_uniform(&state));
        }
        for (i = 0; i < 40; i++) {
            pbw_index a = put(&d, 0.01 * input_uniform(&state), (i + 0.3 + 0.4 * input_uniform(&state)) / 40);
            line(&d, a, put(&d, 1 - 0.3 * input_uniform(&state), (i + 0.3 + 0.4 * input_uniform(&state)) / 40));
        }
        check_drawing(&d, NULL);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("coordinates at 1e15, at 1e-300, clusters of 1e-9")) {
        static const double scale[3] = { 1, 1e-300, 1e-9 }, shift[3] = { 1e15, 0, 1 };
        uint64_t state = 5;
        for (k = 0; k < 3; k++) {
            coast(&d, 0, 0, 1000, 500, &state);
            for (i = 0; i < 1000; i++) {
                d.points[i] = shift[k] + scale[k] * floor(d.points[i]);
            }
            if (k != 1) {                            /* rounded, it may cross itself */
                d.segment_count /= 4;
            }
            {
                pbw_plane_options options;
                memset(&options, 0, sizeof options);
                options.flags = PBW_PLANE_SPLIT_CROSSINGS;
                CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
                check_fault(planes_fault(&plane, d.segments, d.segment_count, 0));
                pbw_plane_free(&plane);
            }
            drawing_free(&d);
        }
        test_end();
    }
    if (test_begin("a hub with 200,000 spokes")) {
        put(&d, 0, 0);
        for (i = 0; i < 200000; i++) {
            double c, s;
            input_turn(i / 1000000.0, &c, &s);
            line(&d, 0, put(&d, c, s));
        }
        CHECK_EQUAL(make(&d, NULL, &plane), PBW_OK);
        CHECK(plane.triangle_count >= 199000 && plane.edge_count >= 200000);
        check_fault(planes_fault(&plane, d.segments, d.segment_count, 1));
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("one segment often, zero lengths, duplicates at ends")) {
        box(&d, 0, 0, 1, 0);
        box(&d, 0, 0, 1, 1);
        for (i = 0; i < 50; i++) {
            line(&d, 0, 2);
            line(&d, 4, 4);
        }
        check_drawing(&d, NULL);
        drawing_free(&d);
        test_end();
    }
}

/* Numbers of segments: several may have one, some none. */
static void test_ids(void)
{
    static const pbw_index ids[] = { 7, 7, PBW_NONE, 3, 3 };
    drawing d;
    pbw_plane plane;
    size_t i, with[2] = { 0, 0 };
    memset(&d, 0, sizeof d);
    if (test_begin("the same bytes for 1 and 4 threads")) {
        pbw_plane_options options;
        pbw_options build;
        pbw_plane other;
        uint64_t state = 4;
        memset(&options, 0, sizeof options);
        memset(&build, 0, sizeof build);
        coast(&d, 0, 0, 1, 30000, &state);
        options.rule = PBW_PLANE_EVEN_ODD;
        options.flags = PBW_PLANE_REFINE;
        options.build = &build;
        build.threads = 1;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        build.threads = 4;
        CHECK_EQUAL(make(&d, &options, &other), PBW_OK);
        CHECK(plane.triangle_count == other.triangle_count && plane.point_count == other.point_count
              && memcmp(plane.triangles, other.triangles, 3 * plane.triangle_count * sizeof *plane.triangles) == 0
              && memcmp(plane.points, other.points, 2 * plane.point_count * sizeof *plane.points) == 0);
        pbw_plane_free(&plane);
        pbw_plane_free(&other);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("the caller's numbers of segments")) {
        box(&d, 0, 0, 1, 0);
        line(&d, 0, 1);
        d.input.segment_ids = ids;
        CHECK_EQUAL(make(&d, NULL, &plane), PBW_OK);
        for (i = 0; i < plane.edge_first[plane.edge_count]; i++) {
            with[plane.edge_segments[i] == 7]++;
            CHECK(plane.edge_segments[i] == 7 || plane.edge_segments[i] == 3);
        }
        CHECK(plane.edge_count == 4 && with[1] == 2 && with[0] == 2);
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
}

static void test_crossings(void)
{
    drawing d;
    pbw_plane plane;
    pbw_plane_options options;
    const size_t n = test_count < 1000000 ? 60 : 1000;               /* make fuzz-plane: a million crossings */
    const double end = 0.1 * (double)n + 1;
    size_t i;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    if (test_begin("a grid of lines: all crossings listed, or split")) {
        for (i = 0; i < n; i++) {
            const pbw_index a = put(&d, 0.1 * (double)i, -1);
            line(&d, a, put(&d, 0.1 * (double)i, end));
        }
        for (i = 0; i < n; i++) {
            const pbw_index a = put(&d, -1, 0.1 * (double)i);
            line(&d, a, put(&d, end, 0.1 * (double)i));
        }
        CHECK_EQUAL(make(&d, NULL, &plane), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(plane.crossing_count, n * n);
        CHECK(plane.crossings[0] == 0 && plane.crossings[1] == n && strstr(plane.what, "cross") != NULL);
        CHECK(plane.triangles == NULL);
        pbw_plane_free(&plane);
        options.flags = PBW_PLANE_SPLIT_CROSSINGS;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        CHECK_EQUAL(plane.point_count, 4 * n + n * n);
        CHECK_EQUAL(plane.report.rounds, 1);
        check_fault(planes_fault(&plane, n > 60 ? NULL : d.segments, d.segment_count, 0));
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("random segments: split until none cross")) {
        uint64_t state = 1;
        for (i = 0; i < 600; i++) {
            const double x = input_uniform(&state), y = input_uniform(&state);
            const pbw_index a = put(&d, x, y);
            line(&d, a, put(&d, x + 0.2 * input_uniform(&state), y + 0.2 * input_uniform(&state)));
        }
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        check_fault(planes_fault(&plane, d.segments, d.segment_count, 0));
        test_say("%zu points, %d rounds", plane.point_count, plane.report.rounds);
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("stars {n/k}: winding k in the middle")) {
        const size_t k = 3;
        options.rule = PBW_PLANE_NONZERO;
        for (i = 0; i < 11; i++) {
            put(&d, cos(2 * PI * (double)i / 11), sin(2 * PI * (double)i / 11));
        }
        for (i = 0; i < 11; i++) {
            line(&d, (pbw_index)i, (pbw_index)((i + k) % 11));
        }
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        check_fault(planes_fault(&plane, NULL, 0, 0));
        for (i = 0; i < plane.region_count; i++) {
            CHECK(plane.region_windings[i] >= 1 && plane.region_windings[i] <= (int)k);
        }
        CHECK_EQUAL(plane.region_count, 1 + 11 * (k - 1));
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
}

/* Makes the mesh of segments that may cross: it is right, or the call says why there is none. */
static void check_answer(drawing *d, unsigned flags, size_t memory, pbw_status other, const char *why)
{
    pbw_plane plane;
    pbw_plane_options options;
    pbw_options build;
    pbw_status status;
    memset(&options, 0, sizeof options);
    memset(&build, 0, sizeof build);
    build.threads = 1;
    build.memory_limit = memory;
    options.build = &build;
    options.flags = flags;
    status = make(d, &options, &plane);
    if (status == PBW_OK) {
        check_fault(planes_fault(&plane, d->segments, d->segment_count, 0));
        CHECK(why == NULL || strstr(why, "settle") != NULL);
    } else {
        CHECK_EQUAL(status, other);
        CHECK(why != NULL && strstr(plane.what, why) != NULL && plane.triangles == NULL);
    }
    pbw_plane_free(&plane);
}

static void test_slivers(void)
{
    static const double scales[] = { 1e-300, 1e-320, 1e300 };
    const unsigned split = PBW_PLANE_SPLIT_CROSSINGS;
    drawing d;
    pbw_plane plane;
    uint64_t state = 5;
    size_t i, k;
    memset(&d, 0, sizeof d);
    if (test_begin("a million equal segments")) {
        put(&d, 0, 0);
        put(&d, 1, 0);
        put(&d, 0, 1);
        for (i = 0; i < 1000000; i++) {
            line(&d, (pbw_index)(i & 1), (pbw_index)(~i & 1));
        }
        CHECK_EQUAL(make(&d, NULL, &plane), PBW_OK);
        CHECK(plane.triangle_count == 1 && plane.edge_first[plane.edge_count] == 1000000);
        for (i = 0; i < 1000000 && plane.edge_segments[i] == i; i++) {
        }
        CHECK_EQUAL(i, 1000000);
        pbw_plane_free(&plane);
        d.segment_count = 100000;
        check_answer(&d, 0, 1 << 20, PBW_ERROR_MEMORY, "memory");
        drawing_free(&d);
        test_end();
    }
    if (test_begin("copies of two segments that cross, in little memory")) {
        box(&d, 0, 0, 1, 0);
        for (i = 0; i < 200; i++) {
            line(&d, (pbw_index)(i & 1), (pbw_index)(2 + (i & 1)));
        }
        check_answer(&d, 0, 0, PBW_ERROR_ARGUMENT, "crossings in all: 10000");
        check_answer(&d, 0, 1 << 17, PBW_ERROR_MEMORY, "memory");
        check_answer(&d, split, 0, PBW_OK, NULL);
        check_answer(&d, split, 1 << 17, PBW_ERROR_MEMORY, "memory");
        drawing_free(&d);
        test_end();
    }
    if (test_begin("segments side by side, 1e-9 apart: more triangles than memory, or than bidden")) {
        pbw_plane_options options;
        memset(&options, 0, sizeof options);
        box(&d, 0, 0, 2, 0);
        stroke(&d, -1, 0, 1, 0);
        stroke(&d, -1, 1e-9, 1, 2e-9);
        check_answer(&d, 0, 0, PBW_OK, NULL);
        check_answer(&d, PBW_PLANE_REFINE, 8 << 20, PBW_ERROR_MEMORY, "memory");
        options.flags = PBW_PLANE_REFINE;
        options.steiner_limit = 1000;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        CHECK(plane.report.limited && plane.report.small_angles > 0);
        check_fault(planes_fault(&plane, d.segments, d.segment_count, 0));
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("segments that cross at 1e-9, at 1e15, at the least and largest scales")) {
        for (i = 0; i < 60; i++) {
            stroke(&d, -1, 1e-9 * (double)i, 1, 1e-9 * (double)(i * 7919 % 61));
        }
        check_answer(&d, split, 0, PBW_ERROR_ARGUMENT, "do not settle");
        drawing_free(&d);
        for (i = 0; i < 50; i++) {
            const double y = 1e15 + floor(0.37 * (double)i);
            stroke(&d, 1e15 + (double)i, y, 1e15 + (double)(10000 + i * 7919 % 1000), y + 3700);
        }
        box(&d, 1e15 + 5000, 1e15 + 2000, 20000, 0);
        check_answer(&d, split, 0, PBW_OK, NULL);
        check_answer(&d, split | PBW_PLANE_REFINE, 0, PBW_OK, NULL);
        drawing_free(&d);
        for (k = 0; k < 3; k++) {
            for (i = 0; i < 40; i++) {
                const double x = scales[k] * input_uniform(&state), y = scales[k] * input_uniform(&state);
                stroke(&d, x, y, scales[k] * input_uniform(&state), scales[k] * input_uniform(&state));
            }
            check_answer(&d, split, 0, PBW_OK, NULL);
            check_answer(&d, split | PBW_PLANE_REFINE, 0, PBW_ERROR_ARGUMENT, "scale them");
            drawing_free(&d);
        }
        test_end();
    }
}

static void test_domains(void)
{
    drawing d;
    pbw_plane plane;
    pbw_plane_options options;
    int i, k;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    if (test_begin("nested squares: winding numbers, even-odd and nonzero")) {
        for (k = 0; k < 2; k++) {
            for (i = 1; i <= 9; i++) {
                box(&d, 0, 0, i, k == 1 && i % 2 == 0);
            }
            options.rule = PBW_PLANE_NONZERO;
            CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
            check_area(&plane, k == 0 ? 2 * 324.0L : 8 * (1 + 9 + 25 + 49 + 81 - 4 - 16 - 36 - 64));
            CHECK_EQUAL(plane.region_count, k == 0 ? 9 : 5);
            for (i = 0; i < (int)plane.region_count; i++) {
                CHECK(plane.region_windings[i] >= 1 && plane.region_windings[i] <= (k == 0 ? 9 : 1));
            }
            pbw_plane_free(&plane);
            options.rule = PBW_PLANE_EVEN_ODD;
            CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
            check_area(&plane, 8 * (1 + 9 + 25 + 49 + 81 - 4 - 16 - 36 - 64));
            pbw_plane_free(&plane);
            check_drawing(&d, &options);
            drawing_free(&d);
        }
        test_end();
    }
    if (test_begin("coasts: area by the shoelace sum")) {
        uint64_t state = 2;
        for (i = 0; i < 9; i++) {
            coast(&d, i % 3, i / 3, 0.3, 1000, &state);
        }
        options.rule = PBW_PLANE_EVEN_ODD;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        check_area(&plane, shoelace(&d));
        CHECK_EQUAL(plane.region_count, 9);
        CHECK_EQUAL(plane.edge_count, d.segment_count);
        pbw_plane_free(&plane);
        check_drawing(&d, &options);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("holes and regions by points, dangling segments")) {
        static const double holes[] = { 0, 0, 3, 3 };
        static const pbw_plane_region regions[] = { { -1.5, 0, 0 }, { 1.5, 0, 0 }, { 0.1, 1.5, 0 } };
        box(&d, 0, 0, 2, 0);
        box(&d, 0, 0, 1, 0);
        line(&d, put(&d, 0, -2), put(&d, 0, -1));
        line(&d, put(&d, 0, 1), put(&d, 0, 2));
        line(&d, 2, put(&d, 1.5, 1.75));             /* sticks out from a corner */
        line(&d, put(&d, 3, 0), put(&d, 4, 0));      /* outside */
        d.input.holes = holes;
        d.input.hole_count = 2;
        d.input.regions = regions;
        d.input.region_count = 3;
        options.rule = PBW_PLANE_SEEDS;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        check_fault(planes_fault(&plane, NULL, 0, 0));
        check_area(&plane, 2 * 12);
        CHECK_EQUAL(plane.region_count, 2);
        CHECK(plane.region_seeds[0] + plane.region_seeds[1] == 2 && plane.region_seeds[0] % 2 == 0);
        pbw_plane_free(&plane);
        options.rule = PBW_PLANE_EVEN_ODD;           /* the cut from hole to border makes windings disagree */
        d.input.hole_count = 0;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_ERROR_ARGUMENT);
        CHECK(strstr(plane.what, "close") != NULL);
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("rings in one call")) {
        static const double points[] = { 0,0, 4,0, 4,4, 0,4, 1,1, 1,2, 2,2, 2,1 };
        static const size_t first[] = { 0, 4, 8 };
        CHECK_EQUAL(pbw_plane_rings(points, first, 2, NULL, &plane), PBW_OK);
        check_fault(planes_fault(&plane, NULL, 0, 0));
        check_area(&plane, 30);
        CHECK_EQUAL(plane.triangle_count, 8);
        CHECK_EQUAL(plane.edge_count, 8);
        pbw_plane_free(&plane);
        CHECK_EQUAL(pbw_plane_rings(points, NULL, 2, NULL, &plane), PBW_ERROR_ARGUMENT);
        CHECK(plane.what[0] != 0);
        CHECK_EQUAL(pbw_plane_rings(NULL, NULL, 0, NULL, &plane), PBW_DEGENERATE);
        pbw_plane_free(&plane);
        test_end();
    }
}

static void draw_rough(drawing *d)
{
    uint64_t state = 4;
    coast(d, 0, 0, 1, 60, &state);
    box(d, 0, 0, 0.3, 1);
    line(d, 0, 30);
}

static void draw_few_slits(drawing *d) { draw_comb(d, 0); }
static void draw_few_boxes(drawing *d) { draw_navmesh_turned(d, 0); }
static void draw_few_crossed(drawing *d) { draw_crossed(d, 0); }

static void (*const draw_failing[])(drawing *) = { draw_rough, draw_few_slits, draw_few_boxes, draw_few_crossed };
enum { FAILING_COUNT = sizeof draw_failing / sizeof *draw_failing };

/* Makes the mesh while the k-th request for memory fails, for up to 150 k. */
static void check_failing(drawing *d, pbw_plane_options *options)
{
    pbw_options build;
    pbw_plane plane;
    meter m;
    uint64_t digest;
    long k, requests, failed = 0;
    memset(&build, 0, sizeof build);
    build.threads = 1;
    build.resize = meter_resize;
    build.resize_user = &m;
    options->build = &build;
    meter_start(&m, 0, 0);
    CHECK_EQUAL(make(d, options, &plane), PBW_OK);
    digest = planes_digest(&plane);
    requests = m.requests;
    pbw_plane_free(&plane);
    for (k = 1; k <= requests; k += 1 + requests / 150) {
        pbw_status status;
        meter_start(&m, k, 0);
        status = make(d, options, &plane);
        CHECK(status == PBW_OK ? planes_digest(&plane) == digest
                               : status == PBW_ERROR_MEMORY && plane.what[0] != 0 && m.blocks == 0);
        failed += status != PBW_OK;
        pbw_plane_free(&plane);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    CHECK(failed > 20);
    build.memory_limit = 10000;
    meter_start(&m, 0, 0);
    CHECK_EQUAL(make(d, options, &plane), PBW_ERROR_MEMORY);
    CHECK(m.blocks == 0 && m.peak <= 10000);
    options->build = NULL;
}

static void test_memory(void)
{
    drawing d;
    pbw_plane_options options;
    double sizes[64];
    int i;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    memset(sizes, 0, sizeof sizes);
    sizes[3] = sizes[50] = 0.01;
    options.rule = PBW_PLANE_SEEDS;
    options.flags = PBW_PLANE_SPLIT_CROSSINGS | PBW_PLANE_REFINE;
    if (test_begin("each allocation failing: the same bytes, or no result")) {
        for (i = 0; i < FAILING_COUNT; i++) {
            draw_failing[i](&d);
            d.input.sizes = i == 0 ? sizes : NULL;
            check_failing(&d, &options);
            drawing_free(&d);
        }
        test_end();
    }
}

static void test_failures(void)
{
    drawing d;
    pbw_plane plane;
    pbw_plane_options options;
    pbw_options build;
    watch w;
    long k, done = 0;
    uint64_t state = 4;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    memset(&build, 0, sizeof build);
    build.threads = 1;
    options.build = &build;
    if (test_begin("bad arguments")) {
        pbw_plane_input none;
        memset(&none, 0, sizeof none);
        CHECK_EQUAL(pbw_plane_make(NULL, NULL, &plane), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_plane_make(&none, NULL, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_plane_make(&none, NULL, &plane), PBW_DEGENERATE);
        pbw_plane_free(&plane);
        box(&d, 0, 0, 1, 0);
        line(&d, 0, 9);
        CHECK_EQUAL(make(&d, NULL, &plane), PBW_ERROR_ARGUMENT);
        CHECK(strstr(plane.what, "segment 4") != NULL);
        d.segment_count = 4;
        options.angle = 35;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_ERROR_ARGUMENT);
        options.angle = 0;
        d.points[3] = HUGE_VAL;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_ERROR_NOT_FINITE);
        CHECK(plane.what[0] != 0);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("points on one line")) {
        for (k = 0; k < 9; k++) {
            line(&d, put(&d, (double)k, (double)k), 0);
        }
        CHECK_EQUAL(make(&d, &options, &plane), PBW_DEGENERATE);
        CHECK(plane.point_count == 9 && plane.triangle_count == 0);
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("cancelled at any call")) {
        for (k = 0; k < 5000; k++) {
            put(&d, input_uniform(&state), input_uniform(&state));
        }
        for (k = 0; k < 4; k++) {
            coast(&d, 3 * (double)k, 0, 1, 3000, &state);
        }
        options.rule = PBW_PLANE_EVEN_ODD;
        build.progress = watch_progress;
        build.progress_user = &w;
        for (k = 1, done = 0; !done; k += 1 + k / 4) {
            watch_start(&w, k);
            done = make(&d, &options, &plane) == PBW_OK;
            CHECK(done || strcmp(plane.what, pbw_status_string(PBW_CANCELLED)) == 0);
            pbw_plane_free(&plane);
        }
        CHECK(k > 10);
        drawing_free(&d);
        test_end();
    }
}

/* ---- refinement */

/* Counts reports by stage, those of the points' triangulation apart, and stops at one of them. */
typedef struct stages { size_t calls[PBW_STAGE_WORK + 1], stop; pbw_stage at; int worked; } stages;

static int count_stages(void *user, pbw_stage stage, double done)
{
    stages *s = (stages *)user;
    s->worked |= stage == PBW_STAGE_WORK;
    s->calls[stage] += (size_t)s->worked;
    CHECK(done >= 0 && done <= 1);
    return s->worked && stage == s->at && s->calls[stage] == s->stop;
}

/* No loop over many triangles is without a report, and each report may end the call. */
static void test_stages(void)
{
    if (test_begin("stages of refinement, and cancelled in each")) {
        drawing d;
        pbw_plane_options options;
        pbw_options build;
        pbw_plane plane;
        stages s;
        size_t full[PBW_STAGE_WORK + 1], stop;
        int at;
        memset(&options, 0, sizeof options);
        memset(&build, 0, sizeof build);
        memset(&s, 0, sizeof s);
        memset(&d, 0, sizeof d);
        box(&d, 0, 0, 1, 0);
        build.threads = 1;
        build.progress = count_stages;
        build.progress_user = &s;
        options.build = &build;
        options.flags = PBW_PLANE_REFINE;
        options.size = 0.02;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        CHECK(s.calls[PBW_STAGE_CHECK] + 1 >= plane.triangle_count / 1024);
        CHECK(s.calls[PBW_STAGE_OUTPUT] + 3 >= (2 * plane.triangle_count + plane.point_count) / 1024);
        CHECK(s.calls[PBW_STAGE_WORK] + 2 >= 2 * plane.report.steiner_count / 1024);
        memcpy(full, s.calls, sizeof full);
        pbw_plane_free(&plane);
        for (at = PBW_STAGE_OUTPUT; at <= PBW_STAGE_WORK; at++) {
            for (stop = 1; stop <= full[at]; stop += 1 + stop / 2) {
                memset(&s, 0, sizeof s);
                s.at = (pbw_stage)at;
                s.stop = stop;
                CHECK_EQUAL(make(&d, &options, &plane), PBW_CANCELLED);
                CHECK(plane.triangle_count == 0 && strcmp(plane.what, pbw_status_string(PBW_CANCELLED)) == 0);
                pbw_plane_free(&plane);
            }
        }
        drawing_free(&d);
        test_end();
    }
}

static double longest_edge(const pbw_plane *plane, size_t i)
{
    double longest = 0;
    size_t k;
    for (k = 0; k < 3; k++) {
        const double *a = planes_at(plane->points, plane->triangles[3 * i + k]);
        const double *b = planes_at(plane->points, plane->triangles[3 * i + (k + 1) % 3]);
        longest = fmax(longest, hypot(a[0] - b[0], a[1] - b[1]));
    }
    return longest;
}

/* Refines; checks the mesh, the segments, the area, and that no more than `small` triangles have smaller angles. */
static void refine(drawing *d, pbw_plane_options *options, size_t small, size_t most, pbw_plane *plane)
{
    pbw_plane coarse;
    size_t i, found = 0;
    const double angle = options->angle > 0 ? options->angle : 30;
    options->flags &= ~PBW_PLANE_REFINE;
    CHECK_EQUAL(make(d, options, &coarse), PBW_OK);
    options->flags |= PBW_PLANE_REFINE;
    CHECK_EQUAL(make(d, options, plane), PBW_OK);
    check_fault(planes_fault(plane, options->rule == PBW_PLANE_HULL ? d->segments : NULL, d->segment_count, 0));
    CHECK(fabsl(planes_area(plane) - planes_area(&coarse)) <= 1e-12L * planes_area(&coarse));
    for (i = 0; i < plane->triangle_count; i++) {
        found += domain_least_angle(plane, i) < angle - 1e-6;
    }
    CHECK_EQUAL(found, plane->report.small_angles);
    CHECK(found <= small);
    CHECK(plane->triangle_count <= most && !plane->report.limited);
    test_say("%g degrees: %zu triangles, %zu with smaller angles", angle, plane->triangle_count, found);
    pbw_plane_free(&coarse);
}

/* Finer towards a corner. */
static double size_at(void *user, double x, double y)
{
    (void)user;
    return 0.01 + 0.1 * hypot(x, y);
}

static void test_angles(void)
{
    static const double angles[3] = { 20, 30, 33 };
    static const size_t of_plate[3] = { 31000, 43500, 69000 }, of_coast[3] = { 3100, 4400, 6500 };
    drawing d;
    pbw_plane plane;
    pbw_plane_options options;
    uint64_t state = 1;
    int i, k;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    if (test_begin("angles of a plate with 20 rings")) {
        plate(&d);
        for (k = 0; k < 3; k++) {
            options.angle = angles[k];
            refine(&d, &options, 0, of_plate[k], &plane);
            pbw_plane_free(&plane);
        }
        drawing_free(&d);
        test_end();
    }
    if (test_begin("angles of a comb and of a coast")) {
        options.rule = PBW_PLANE_EVEN_ODD;
        for (k = 0; k < 3; k++) {
            options.angle = angles[k];
            put(&d, 0, 0);
            for (i = 0; i < 50; i++) {
                put(&d, i + 1, 0);
                put(&d, i + 1, 1);
                put(&d, i + 1.02, 1);
                put(&d, i + 1.02, 0);
            }
            put(&d, 51, 0);
            put(&d, 51, 2);
            put(&d, 0, 2);
            ring(&d, d.point_count);
            refine(&d, &options, 0, 6000, &plane);
            pbw_plane_free(&plane);
            drawing_free(&d);
            coast(&d, 0, 0, 1, 1000, &state);
            refine(&d, &options, 0, 10 * of_coast[k], &plane);
            pbw_plane_free(&plane);
            drawing_free(&d);
        }
        memset(&options, 0, sizeof options);
        test_end();
    }
    if (test_begin("small angles of the input: spokes, wedges")) {
        static const double wedge[4] = { 30, 10, 1, 0.01 };
        box(&d, 0, 0, 2, 0);
        put(&d, 0, 0);
        for (i = 0; i < 40; i++) {
            double c, s;
            input_turn(i / 40.0 + 1e-3 * input_uniform(&state), &c, &s);
            line(&d, 4, put(&d, c, s));
        }
        refine(&d, &options, 80, 550, &plane);
        pbw_plane_free(&plane);
        drawing_free(&d);
        for (k = 0; k < 4; k++) {
            box(&d, 0, 0, 2, 0);
            put(&d, 0, 0);
            put(&d, 1, 0.1);
            put(&d, cos(wedge[k] * PI / 180), 0.1 * cos(wedge[k] * PI / 180) + sin(wedge[k] * PI / 180));
            line(&d, 4, 5);
            line(&d, 4, 6);
            refine(&d, &options, 40, 2000, &plane);
            pbw_plane_free(&plane);
            drawing_free(&d);
        }
        test_end();
    }
}

/* Whether the edges of each segment are together as long as it is, but for points an ulp beside it. */
static void check_lengths(const drawing *d, const pbw_plane *plane)
{
    double *length = (double *)zoo_grow(NULL, (d->segment_count + 1) * sizeof *length);
    size_t i, k, wrong = 0;
    for (i = 0; i < d->segment_count; i++) {
        const double *a = planes_at(d->points, d->segments[2 * i]), *b = planes_at(d->points, d->segments[2 * i + 1]);
        length[i] = hypot(a[0] - b[0], a[1] - b[1]);
    }
    for (i = 0; i < plane->edge_count; i++) {
        const double *a = planes_at(plane->points, plane->edges[2 * i]);
        const double *b = planes_at(plane->points, plane->edges[2 * i + 1]);
        for (k = plane->edge_first[i]; k < plane->edge_first[i + 1]; k++) {
            length[plane->edge_segments[k]] -= hypot(a[0] - b[0], a[1] - b[1]);
        }
    }
    for (i = 0; i < d->segment_count; i++) {
        const double *a = planes_at(d->points, d->segments[2 * i]), *b = planes_at(d->points, d->segments[2 * i + 1]);
        const double ulp = 2.3e-16 * (fabs(a[0]) + fabs(a[1]) + fabs(b[0]) + fabs(b[1]));
        wrong += !(fabs(length[i]) <= 1e-12 * hypot(a[0] - b[0], a[1] - b[1]) + 1000 * ulp);
    }
    CHECK_EQUAL(wrong, 0);
    free(length);
}

/* Every domain of the table: one set of triangles for every order; no angle below the bound, but at small angles. */
static void test_domain(const domain *e, int full, size_t *sharp_at_33)
{
    drawing d;
    pbw_plane plane;
    pbw_plane_options options;
    domain_verdict v;
    int i;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    options.rule = e->rule;
    options.flags = e->flags;
    e->make(&d, full);
    check_drawing(&d, &options);
    if (e->make == draw_tiny) {
        options.flags |= PBW_PLANE_REFINE;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_ERROR_ARGUMENT);
        CHECK(strstr(plane.what, "scale") != NULL);
        drawing_free(&d);
        return;
    }
    for (i = 0; i < 2; i++) {
        options.angle = i == 0 ? 30 : 33;
        refine(&d, &options, SIZE_MAX, SIZE_MAX, &plane);
        check_lengths(&d, &plane);
        v = domain_judge(&d, &plane, options.angle);
        CHECK(v.sharp_free == 0 || i == 1);
        CHECK_EQUAL(plane.report.too_large, 0);
        CHECK_EQUAL(plane.report.short_edges, 0);
        *sharp_at_33 += i == 1 && v.sharp_free > 0;
        pbw_plane_free(&plane);
    }
    drawing_free(&d);
}

static void test_domain_table(void)
{
    const int full = test_count >= 1000000;
    size_t sharp = 0;
    int i;
    for (i = 0; i < DOMAIN_COUNT; i++) {
        if (test_begin("domains: %s", domains[i].name)) {
            test_domain(domains + i, full, &sharp);
            test_end();
        }
    }
    if (test_begin("domains: 33 degrees on 95 of 100")) {
        CHECK(20 * sharp <= DOMAIN_COUNT);
        test_end();
    }
}

/* ---- how many triangles */

static void draw_squares(drawing *d)
{
    int i;
    for (i = 0; i < 144; i++) {
        box(d, i % 12, i / 12, 0.45, 0);
    }
    rectangle(d, -1, -1, 12, 12);
}

static void draw_teeth(drawing *d)
{
    int i;
    put(d, 0, -1);
    put(d, 20, -1);
    for (i = 19; i >= 0; i--) {
        put(d, i + 0.51, 0);
        put(d, i + 0.51, 3);
        put(d, i + 0.49, 3);
        put(d, i + 0.49, 0);
    }
    put(d, 0, 0);
    ring(d, d->point_count);
}

static void draw_sun(drawing *d)
{
    int i;
    for (i = 0; i < 112; i++) {
        double c, s;
        input_turn(i / 112.0, &c, &s);
        put(d, i % 2 ? 0.6 * c : c, i % 2 ? 0.6 * s : s);
    }
    ring(d, d->point_count);
    box(d, 0, 0, 2, 0);
}

static void draw_sieve(drawing *d)
{
    int i;
    for (i = 0; i < 1200; i++) {
        double c, s;
        input_turn(-(i % 12) / 12.0, &c, &s);
        put(d, i / 12 % 10 + 0.06 * c, i / 120 + 0.06 * s);
        if (i % 12 == 11) {
            ring(d, 12);
        }
    }
    rectangle(d, -1, -1, 10, 10);
}

/* The least counts are not known; the bounds are what refinement reached with moves and splits at the places that
   serve best, and 1 percent, as sines differ by an ulp among libraries.  Without both it made up to 3.6 times as
   many. */
static void test_counts(void)
{
    static const struct { const char *name; void (*make)(drawing *d); pbw_plane_rule rule; size_t most[2]; } few[] = {
        { "a lattice of squares", draw_squares, PBW_PLANE_SEEDS, { 6290, 6550 } },
        { "a comb of thin teeth", draw_teeth, PBW_PLANE_EVEN_ODD, { 2110, 2563 } },
        { "a star", draw_sun, PBW_PLANE_SEEDS, { 531, 645 } },
        { "a plate with many holes", draw_sieve, PBW_PLANE_EVEN_ODD, { 9013, 9888 } }
    };
    size_t i, k;
    for (i = 0; i < sizeof few / sizeof *few; i++) {
        if (test_begin("few triangles: %s", few[i].name)) {
            for (k = 0; k < 2; k++) {
                const double angle = k == 0 ? 30 : 33;
                pbw_plane_options options;
                pbw_plane plane;
                drawing d;
                memset(&d, 0, sizeof d);
                memset(&options, 0, sizeof options);
                few[i].make(&d);
                options.rule = few[i].rule;
                options.flags = PBW_PLANE_REFINE;
                options.angle = angle;
                if (CHECK_EQUAL(make(&d, &options, &plane), PBW_OK)) {
                    test_say("%.0f degrees: %lu triangles", angle, (unsigned long)plane.triangle_count);
                    CHECK(plane.triangle_count <= few[i].most[k]);
                    CHECK_EQUAL(domain_judge(&d, &plane, angle).sharp_free, 0);
                    check_fault(planes_fault(&plane, d.segments, d.segment_count, 0));
                }
                pbw_plane_free(&plane);
                drawing_free(&d);
            }
            test_end();
        }
    }
}

static void test_sizes(void)
{
    static const pbw_plane_region regions[] = { { -0.5, 0, 0.001 }, { 0.5, 0, 0.01 } };
    static const double sizes[4] = { 0.02, 0, 0, 0 };
    drawing d;
    pbw_plane plane;
    pbw_plane_options options;
    size_t i, k;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    if (test_begin("area, size, size by place: none is larger; not many more than needed")) {
        box(&d, 0.5, 0.5, 0.5, 0);
        options.area = 1e-4;
        refine(&d, &options, 0, 16200, &plane);
        CHECK_EQUAL(plane.report.too_large, 0);
        pbw_plane_free(&plane);
        options.area = 0;
        options.size = 0.05;
        refine(&d, &options, 0, 2500, &plane);
        for (i = 0; i < plane.triangle_count; i++) {
            CHECK(longest_edge(&plane, i) <= 0.05);
        }
        pbw_plane_free(&plane);
        options.size = 0;
        options.size_at = size_at;
        refine(&d, &options, 0, 3500, &plane);
        CHECK_EQUAL(plane.report.too_large, 0);
        for (i = 0; i < plane.triangle_count; i++) {
            double x = 0, y = 0;
            for (k = 0; k < 3; k++) {
                x += planes_at(plane.points, plane.triangles[3 * i + k])[0] / 3;
                y += planes_at(plane.points, plane.triangles[3 * i + k])[1] / 3;
            }
            CHECK(longest_edge(&plane, i) <= 1.0001 * size_at(NULL, x, y));
        }
        pbw_plane_free(&plane);
        options.size_at = NULL;
        d.input.sizes = sizes;
        refine(&d, &options, 0, 6000, &plane);
        for (i = 0; i < plane.triangle_count; i++) {
            for (k = 0; k < 3; k++) {
                CHECK(plane.triangles[3 * i + k] != 0 || longest_edge(&plane, i) <= 0.05);
            }
        }
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("areas of regions")) {
        box(&d, 0, 0, 1, 0);
        line(&d, put(&d, 0, -1), put(&d, 0, 1));
        d.input.regions = regions;
        d.input.region_count = 2;
        refine(&d, &options, 0, 6000, &plane);
        CHECK_EQUAL(plane.region_count, 2);
        for (i = 0; i < plane.triangle_count; i++) {
            const double *a = planes_at(plane.points, plane.triangles[3 * i]);
            const double *b = planes_at(plane.points, plane.triangles[3 * i + 1]);
            const double *c = planes_at(plane.points, plane.triangles[3 * i + 2]);
            const pbw_index seed = plane.region_seeds[plane.regions[i]];
            CHECK((a[0] + b[0] + c[0] < 0) == (seed == 0));
            CHECK((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) <= 2.0001 * regions[seed].area);
        }
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
}

/* Fine in a disc, coarse outside. */
static double disc_at(void *user, double x, double y)
{
    (void)user;
    return hypot(x - 0.5, y - 0.5) < 0.1 ? 0.01 : 1;
}

/* The most that a triangle's longest edge exceeds a size which grows from a disc by: as a ratio. */
static double excess(const pbw_plane *plane, const double *centre, double radius, double size, double growth)
{
    double most = 0;
    size_t i, k;
    for (i = 0; i < plane->triangle_count; i++) {
        double x = 0, y = 0;
        for (k = 0; k < 3; k++) {
            x += planes_at(plane->points, plane->triangles[3 * i + k])[0] / 3;
            y += planes_at(plane->points, plane->triangles[3 * i + k])[1] / 3;
        }
        x = fmax(0, hypot(x - centre[0], y - centre[1]) - radius);
        most = fmax(most, longest_edge(plane, i) / (size + growth * x));
    }
    return most;
}

static void test_growth(void)
{
    static const double centre[] = { 0.5, 0.5 }, low[] = { 0.5, 0.01 }, growth[] = { 0.1, 0.2, 0.3 };
    static const pbw_plane_region regions[] = { { -0.5, 0, 1e-4 }, { 0.5, 0, 0 } };
    static const double sizes[] = { 0, 0, 0, 0, 0.005 };
    static const size_t of_point[] = { 3400, 1300, 700 }, of_disc[] = { 7500, 4600, 3700 };
    drawing d;
    pbw_plane plane;
    pbw_plane_options options;
    size_t plain = 0, i, k;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    if (test_begin("sizes grow from a point, from a disc of a function, no faster than bidden")) {
        box(&d, 0.5, 0.5, 0.5, 0);
        put(&d, low[0], low[1]);
        for (i = 0; i < 3; i++) {
            options.gradation = growth[i];
            d.input.sizes = sizes;
            options.size_at = NULL;
            refine(&d, &options, 0, of_point[i], &plane);
            CHECK(excess(&plane, low, 0, 0.005, growth[i]) < 1.15);
            CHECK(plane.triangle_count > of_point[i] / 2);
            pbw_plane_free(&plane);
            d.input.sizes = NULL;
            options.size_at = disc_at;
            refine(&d, &options, 0, of_disc[i], &plane);
            CHECK(excess(&plane, centre, 0.1, 0.01, growth[i]) < 1.25);
            pbw_plane_free(&plane);
        }
        options.gradation = 0;                       /* a function grows as it likes */
        refine(&d, &options, 0, 2500, &plane);
        CHECK(excess(&plane, centre, 0.1, 0.01, 0.2) > 2);
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("sizes grow from a fine region into the next")) {
        options.size_at = NULL;
        box(&d, 0, 0, 1, 0);
        line(&d, put(&d, 0, -1), put(&d, 0, 1));
        d.input.regions = regions;
        d.input.region_count = 2;
        for (i = 0; i < 3; i++) {
            size_t coarse = 0;
            options.gradation = 0.1 * (double)i;
            refine(&d, &options, 0, 36000, &plane);
            for (k = 0; k < plane.triangle_count; k++) {
                coarse += plane.region_seeds[plane.regions[k]] == 1;
            }
            plain = i == 0 ? coarse : plain;
            CHECK(i == 0 || coarse > (i == 1 ? 3 : 2) * plain / 2);
            pbw_plane_free(&plane);
        }
        drawing_free(&d);
        test_end();
    }
}

/* ---- more triangles than wanted */

typedef struct strip { double size, growth, x; size_t calls; } strip;        /* a size at x, which grows from there */

static double strip_at(void *user, double x, double y)
{
    strip *s = (strip *)user;
    (void)y;
    s->calls++;
    return fmax(s->size, s->growth * fabs(x - s->x));
}

/* Sizes that ask for far too much, each in its own way; none of them can be a mesh.  The unit square. */
static void test_refused(drawing *d)
{
    static const pbw_plane_region tiny[] = { { 0.5, 0.5, 1e-160 } };
    static const double sizes[4] = { 1e-9, 1e-9, 1e-9, 1e-9 };
    strip everywhere = { 1e-9, 0, 0, 0 };
    int way;
    for (way = 0; way < 7; way++) {
        pbw_options build;
        pbw_plane_options options;
        pbw_plane_input input = *input_of(d);
        pbw_plane plane;
        memset(&build, 0, sizeof build);
        memset(&options, 0, sizeof options);
        build.memory_limit = 100000;                 /* what work would end at */
        options.build = &build;
        options.flags = PBW_PLANE_REFINE;
        options.area = way == 0 ? 1e-160 : way == 1 ? 1e-320 : 0;
        options.size = way == 2 ? 1e-9 : 0;
        input.regions = tiny;
        input.region_count = way == 3;
        input.sizes = way == 4 ? sizes : NULL;
        options.size_at = way > 4 ? strip_at : NULL;
        options.size_user = &everywhere;
        options.gradation = way == 6 ? 0.2 : 0;
        CHECK_EQUAL(pbw_plane_make(&input, &options, &plane), PBW_ERROR_TOO_LARGE);
        CHECK(plane.report.estimate > 1e15 && plane.report.estimate < 1e21);
        CHECK(strstr(plane.what, " triangles, more than most = 50000000 allows") != NULL);
        CHECK(plane.triangle_count == 0 && everywhere.calls < 100);
        options.steiner_limit = 20;                  /* which bounds the work, too */
        CHECK_EQUAL(pbw_plane_make(&input, &options, &plane), PBW_OK);
        CHECK(plane.report.limited && plane.report.steiner_count == 20 && plane.report.estimate <= 42);
        pbw_plane_free(&plane);
        options.steiner_limit = 0;
        everywhere.calls = 0;
    }
}

static void test_most(void)
{
    static const struct { double area, size, function; } row[] = {
        { 1e-4, 0, 0 }, { 0, 0.02, 0 }, { 1e-2, 0.02, 0 }, { 1e-4, 1, 0 }, { 0, 0, 0.02 }, { 0, 0.02, 0.5 }
    };
    drawing d;
    pbw_plane plane;
    pbw_plane_options options;
    size_t i, count = 0;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    options.flags = PBW_PLANE_REFINE;
    rectangle(&d, 0, 0, 1, 1);
    if (test_begin("sizes that ask for too many triangles")) {
        test_refused(&d);
        test_end();
    }
    if (test_begin("estimates of the number of triangles")) {
        for (i = 0; i < sizeof row / sizeof *row; i++) {
            strip s = { row[i].function, 0, 0, 0 };
            options.area = row[i].area;
            options.size = row[i].size;
            options.size_at = s.size > 0 ? strip_at : NULL;
            options.size_user = &s;
            options.most = 20000;
            CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
            CHECK(plane.report.estimate > 0.9 * (double)plane.triangle_count);
            CHECK(plane.report.estimate < 1.1 * (double)plane.triangle_count);
            pbw_plane_free(&plane);
            options.most = 10000;
            CHECK_EQUAL(make(&d, &options, &plane), PBW_ERROR_TOO_LARGE);
            CHECK(plane.report.estimate > 10000 && plane.what[0] != 0);
        }
        test_end();
    }
    memset(&options, 0, sizeof options);
    options.flags = PBW_PLANE_REFINE;
    if (test_begin("a function that is small in a small part")) {
        strip s = { 2e-3, 0.25, 1.0 / 3, 0 };        /* at the middle of a triangle of the square */
        options.size_at = strip_at;
        options.size_user = &s;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        CHECK(plane.triangle_count > 20000 && plane.report.estimate < 1000);
        count = plane.triangle_count;
        pbw_plane_free(&plane);
        options.most = 5000;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_ERROR_TOO_LARGE);
        CHECK(plane.report.estimate > 5000 && plane.report.estimate < 5100 && plane.triangle_count == 0);
        options.most = 1.1 * (double)count;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        CHECK_EQUAL(plane.triangle_count, count);
        pbw_plane_free(&plane);
        options.size_at = NULL;
        test_end();
    }
    if (test_begin("angles alone, and numbers that are none")) {
        drawing_free(&d);
        draw_teeth(&d);
        options.rule = PBW_PLANE_EVEN_ODD;
        options.most = 1000;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_ERROR_TOO_LARGE);
        CHECK(plane.report.estimate > 1000 && plane.report.estimate < 1100);
        options.most = 2500;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        pbw_plane_free(&plane);
        options.most = 1;
        options.flags = 0;                           /* of refinement only */
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        pbw_plane_free(&plane);
        options.most = -1;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_ERROR_ARGUMENT);
        options.most = HUGE_VAL - HUGE_VAL;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_ERROR_ARGUMENT);
        test_end();
    }
    drawing_free(&d);
}

static void test_limits(void)
{
    drawing d;
    pbw_plane plane;
    pbw_plane_options options;
    size_t i;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    options.flags = PBW_PLANE_REFINE;
    if (test_begin("a most number of points")) {
        plate(&d);
        options.steiner_limit = 500;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        CHECK(plane.report.limited && plane.report.steiner_count == 500);
        CHECK(plane.point_count == d.point_count + 500);
        check_fault(planes_fault(&plane, d.segments, d.segment_count, 0));
        pbw_plane_free(&plane);
        options.steiner_limit = 0;
        test_end();
    }
    test_most();
    if (test_begin("untouched boundary, untouched segments, conforming")) {
        pbw_mesh mesh;
        const size_t given = d.segment_count + 1;
        size_t at_border = 0;
        memset(&mesh, 0, sizeof mesh);
        line(&d, put(&d, 0, 0.2), put(&d, 10, 0.2));
        options.area = 0.05;
        options.flags = PBW_PLANE_REFINE | PBW_PLANE_KEEP_SEGMENTS;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        CHECK(plane.edge_count == given && plane.report.steiner_count > 100);
        check_fault(planes_fault(&plane, d.segments, d.segment_count, 1));
        pbw_plane_free(&plane);
        options.flags = PBW_PLANE_REFINE | PBW_PLANE_KEEP_BOUNDARY;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        CHECK(plane.edge_count > given);
        for (i = 0; i < 3 * plane.triangle_count; i++) {
            at_border += plane.neighbors[i] == PBW_NONE;
        }
        CHECK_EQUAL(at_border, 4);
        pbw_plane_free(&plane);
        options.flags = PBW_PLANE_REFINE | PBW_PLANE_CONFORMING;
        options.angle = -1;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        CHECK_EQUAL(pbw_triangulate(2, plane.points, NULL, plane.point_count, NULL, &mesh), PBW_OK);
        CHECK(mesh.simplex_count >= plane.triangle_count);
        for (i = 0; i < 3 * plane.triangle_count; i++) {             /* Delaunay across segments too */
            const pbw_index n = plane.neighbors[i], *v = plane.triangles + 3 * (i / 3);
            size_t k;
            for (k = 0; n != PBW_NONE && plane.neighbors[3 * (size_t)n + k] != i / 3; k++) {
            }
            CHECK(n == PBW_NONE || pbw_incircle(planes_at(plane.points, v[0]), planes_at(plane.points, v[1]),
                  planes_at(plane.points, v[2]),
                  planes_at(plane.points, plane.triangles[3 * (size_t)n + k])) <= 0);
        }
        pbw_free(&mesh);
        pbw_plane_free(&plane);
        drawing_free(&d);
        test_end();
    }
    if (test_begin("a point beside a segment by less than an ulp")) {
        put(&d, 0.5, 0.1);
        put(&d, 0.2, 0.4);
        put(&d, 0.30000000000000004, 0.30000000000000004);
        put(&d, 0.1, 0.4);
        put(&d, 0, 0);
        line(&d, 0, 1);
        options.flags = PBW_PLANE_REFINE;
        options.angle = 30;
        options.steiner_limit = 2000;
        CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
        CHECK(!plane.report.limited && plane.report.small_angles > 0);
        check_fault(plane.points == NULL ? plane.what : planes_fault(&plane, d.segments, d.segment_count, 0));
        pbw_plane_free(&plane);
        options.steiner_limit = 0;
        drawing_free(&d);
        test_end();
    }
    if (test_begin("segments that meet at angles down to 1e-12")) {
        double angle;
        for (angle = 0.1; angle > 1e-12; angle /= 10) {
            put(&d, 0, 0);
            put(&d, 1, 0);
            put(&d, 0.77, 0.77 * angle);
            put(&d, 0.3, 1);
            line(&d, 0, 1);
            line(&d, 0, 2);
            line(&d, 0, 3);
            line(&d, 3, 1);
            options.steiner_limit = 200;
            CHECK_EQUAL(make(&d, &options, &plane), PBW_OK);
            CHECK(!plane.report.limited && plane.report.small_angles > 0);
            check_fault(plane.points == NULL ? plane.what : planes_fault(&plane, d.segments, d.segment_count, 0));
            pbw_plane_free(&plane);
            drawing_free(&d);
        }
        options.steiner_limit = 0;
        test_end();
    }
    if (test_begin("coordinates that cannot be refined")) {
        options.flags = PBW_PLANE_REFINE;
        put(&d, 0, 0);
        put(&d, 1e200, 0);
        put(&d, 0, 1e200);
        CHECK_EQUAL(make(&d, &options, &plane), PBW_ERROR_ARGUMENT);
        CHECK(strstr(plane.what, "scale") != NULL);
        drawing_free(&d);
        test_end();
    }
}

static void test_random(void)
{
    if (test_begin("%ld random small inputs", test_count)) {
        uint64_t state = test_seed;
        unsigned char bytes[512];
        long n;
        int i;
        for (n = 0; n < test_count; n++) {
            planes_small s;
            const char *fault;
            size_t size;
            for (i = 0; i < (int)sizeof bytes; i += 8) {
                uint64_t x = input_next(&state);
                memcpy(bytes + i, &x, 8);
            }
            size = 64 + input_below(&state, 449);
            planes_small_decode(&s, bytes, size);
            fault = planes_small_judge(&s);
            if (!CHECK(fault == NULL)) {
                test_say("%s", fault);
                planes_small_decode(&s, bytes, size);
                planes_small_print(&s);
            }
        }
        test_end();
    }
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 3000);
    test_constraints();
    test_ids();
    test_crossings();
    test_slivers();
    test_domains();
    test_angles();
    test_domain_table();
    test_counts();
    test_sizes();
    test_growth();
    test_limits();
    test_memory();
    test_failures();
    test_stages();
    test_random();
    return test_finish();
}
