/* test_mesh3.c: solids: the right Euler number, volume and angles of shapes whose volume is known, sharp edges kept,
   shapes turned so that planes are uneven; warnings where they belong; the same bytes for every number of threads;
   sound after every failure. */
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_MESH3_IMPLEMENTATION
#include "pbw_mesh3.h"
#include "pbw_stuffing.h"
#include "meter.h"
#include "parts.h"
#include "test.h"
#include "watch.h"
#include "zoo.h"
#include <math.h>

#define PI 3.14159265358979323846

/* ---- shapes ---- */

static double sphere(void *user, const double p[3])
{
    (void)user;
    return sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 1;
}

static double hollow(void *user, const double p[3])
{
    return fmax(sphere(user, p), -0.5 - sphere(user, p));
}

static double torus(void *user, const double p[3])
{
    const double r = sqrt(p[0] * p[0] + p[1] * p[1]) - 1;
    (void)user;
    return r * r + p[2] * p[2] - 0.1225;
}

typedef struct model { double x[1000][3]; pbw_index t[2000][3]; size_t points, triangles; } model;

static void turn(model *m)
{
    size_t i;
    int k;
    for (i = 0; i < m->points; i++) {
        for (k = 0; k < 3; k++) {
            double *a = m->x[i] + k, *b = m->x[i] + (k + 1) % 3, was = *a;
            *a = 0.8 * was - 0.6 * *b;
            *b = 0.6 * was + 0.8 * *b;
        }
    }
}

static void add_triangle(model *m, size_t a, size_t b, size_t c)
{
    m->t[m->triangles][0] = (pbw_index)a;
    m->t[m->triangles][1] = (pbw_index)b;
    m->t[m->triangles++][2] = (pbw_index)c;
}

/* A prism over the ring between two polygons of n corners. */
static void make_prism(model *m, size_t n, const double (*outer)[2], const double (*inner)[2], double height)
{
    const size_t o = 0, i = n, up = 2 * n;
    size_t k;
    memset(m, 0, sizeof *m);
    for (k = 0; k < 4 * n; k++) {
        const double *p = k / n % 2 == 0 ? outer[k % n] : inner[k % n];
        m->x[k][0] = p[0];
        m->x[k][1] = p[1];
        m->x[k][2] = k < 2 * n ? 0 : height;
    }
    m->points = 4 * n;
    for (k = 0; k < n; k++) {
        const size_t l = (k + 1) % n;
        add_triangle(m, o + k, i + k, o + l);
        add_triangle(m, o + l, i + k, i + l);
        add_triangle(m, up + o + k, up + o + l, up + i + k);
        add_triangle(m, up + o + l, up + i + l, up + i + k);
        add_triangle(m, o + k, o + l, up + o + l);
        add_triangle(m, o + k, up + o + l, up + o + k);
        add_triangle(m, i + k, up + i + k, up + i + l);
        add_triangle(m, i + k, up + i + l, i + l);
    }
}

/* A unit cube with a round hole of radius 1/4. */
static double make_hole(model *m)
{
    double outer[32][2], inner[32][2];
    size_t k;
    for (k = 0; k < 32; k++) {
        const double a = 2 * PI * (double)k / 32 - 0.75 * PI, along = (double)(k % 8) / 8;
        inner[k][0] = 0.5 + 0.25 * cos(a);
        inner[k][1] = 0.5 + 0.25 * sin(a);
        outer[k][0] = k < 8 ? along : k < 16 ? 1 : k < 24 ? 1 - along : 0;
        outer[k][1] = k < 8 ? 0 : k < 16 ? along : k < 24 ? 1 : 1 - along;
    }
    make_prism(m, 32, (const double (*)[2])outer, (const double (*)[2])inner, 1);
    return 1 - 16 * sin(2 * PI / 32) / 16;
}

/* A prism over an L of two squares; the inner polygon is one point. */
static double make_l(model *m)
{
    static const double outer[6][2] = { { 0, 0 }, { 2, 0 }, { 2, 1 }, { 1, 1 }, { 1, 2 }, { 0, 2 } };
    double inner[6][2];
    size_t k;
    for (k = 0; k < 6; k++) {
        inner[k][0] = inner[k][1] = 0.5;
    }
    make_prism(m, 6, outer, (const double (*)[2])inner, 1);
    m->triangles = 0;                                /* without the inner walls, which have no area */
    for (k = 0; k < 6; k++) {
        const size_t l = (k + 1) % 6;
        add_triangle(m, k, 6, l);
        add_triangle(m, 12 + k, 12 + l, 18);
        add_triangle(m, k, l, 12 + l);
        add_triangle(m, k, 12 + l, 12 + k);
    }
    return 3;
}

static pbw_solid_input input_of(const model *m)
{
    pbw_solid_input in;
    memset(&in, 0, sizeof in);
    in.points = m->x[0];
    in.point_count = m->points;
    in.triangles = m->t[0];
    in.triangle_count = m->triangles;
    return in;
}

static pbw_solid_input input_by(double (*value)(void *, const double *))
{
    pbw_solid_input in;
    int k;
    memset(&in, 0, sizeof in);
    in.value = value;
    for (k = 0; k < 3; k++) {
        in.box[k] = -1.5;
        in.box[3 + k] = 1.5;
    }
    return in;
}

/* ---- what must hold ---- */

static int is_sound(const pbw_tets *t)
{
    char *used = (char *)zoo_grow(NULL, t->point_count + 1);
    size_t i, k, orphans = t->point_count;
    int sound = 1;
    memset(used, 0, t->point_count + 1);
    for (i = 0; i < t->tet_count; i++) {
        const pbw_index *c = t->corners + 4 * i;
        for (k = 0; k < 4; k++) {
            orphans -= !used[c[k]];
            used[c[k]] = 1;
        }
        sound &= pbw_orient3(t->points + 3 * (size_t)c[0], t->points + 3 * (size_t)c[1], t->points + 3 * (size_t)c[2],
                             t->points + 3 * (size_t)c[3]) > 0;
    }
    free(used);
    return sound && orphans == 0;
}

/* A solid with a known volume: settled, a manifold, good angles. */
static void check_good(const pbw_solid_input *in, double size, double volume, long euler, double least)
{
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_options threads;
    pbw_tets mesh, other;
    memset(&how, 0, sizeof how);
    memset(&threads, 0, sizeof threads);
    how.size = size;
    threads.threads = 1;
    CHECK_EQUAL(pbw_solid(in, &how, &threads, &mesh, &r), PBW_OK);
    CHECK(is_sound(&mesh));
    CHECK_EQUAL(r.settled, 1);
    CHECK_EQUAL(r.bad_edges + r.bad_points + r.missing_edges + r.open_edges + r.crowded_edges, 0);
    CHECK_EQUAL(r.euler, euler);
    CHECK(fabs(r.improve.after.volume - volume) < 0.03 * volume);
    CHECK(r.distance < 0.3);
    CHECK(r.improve.after.least > least && r.improve.after.largest < 180 - least);
    if (r.bad_edges + r.bad_points + r.missing_edges > 0) {
        test_say("%zu bad edges, %zu bad points, %zu missing edges", r.bad_edges, r.bad_points, r.missing_edges);
        test_say("first at %.9g %.9g %.9g", r.places[0][0], r.places[0][1], r.places[0][2]);
    }
    test_say("%zu tetrahedra %.2f..%.2f, distance %.3f, volume %.5f of %.5f, %d rounds", mesh.tet_count,
             r.improve.after.least, r.improve.after.largest, r.distance, r.improve.after.volume, volume, r.rounds);
    threads.threads = 4;
    CHECK_EQUAL(pbw_solid(in, &how, &threads, &other, NULL), PBW_OK);
    CHECK(mesh.tet_count == other.tet_count && mesh.point_count == other.point_count
          && memcmp(mesh.corners, other.corners, 16 * mesh.tet_count) == 0
          && memcmp(mesh.points, other.points, 24 * mesh.point_count) == 0);
    pbw_tets_free(&other);
    pbw_tets_free(&mesh);
}

static void test_functions(void)
{
    pbw_solid_input in;
    if (test_begin("functions")) {
        in = input_by(sphere);
        check_good(&in, 0.2, 4 * PI / 3, 2, 28);
        in = input_by(hollow);
        check_good(&in, 0.15, 4 * PI / 3 * 0.875, 4, 26);
        in = input_by(torus);
        check_good(&in, 0.15, 2 * PI * PI * 0.1225, 0, 26);
        test_end();
    }
}

/* Acute edges: kept, settled, volumes right to rounding; the angles are those of the input or better. */
static void test_acute(void)
{
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    int i;
    if (!test_begin("acute edges")) {
        return;
    }
    for (i = 0; i < 4; i++) {
        const size_t number = i < 2 ? PART_WEDGE : PART_SPIKE;
        const double volume = part_make(number, i % 2, &m);
        memset(&how, 0, sizeof how);
        memset(&in, 0, sizeof in);
        in.points = m.x[0];
        in.point_count = m.points;
        in.triangles = m.t[0];
        in.triangle_count = m.triangles;
        how.size = 0.1;
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &r), PBW_OK);
        CHECK(is_sound(&mesh));
        CHECK_EQUAL(r.settled, 1);
        CHECK_EQUAL(r.bad_edges + r.bad_points + r.missing_edges, 0);
        CHECK_EQUAL(r.euler, 2);
        CHECK(fabs(r.improve.after.volume - volume) < 1e-12 && r.distance < 1e-12);
        CHECK(r.improve.after.least > (i < 2 ? 18 : 28));
        CHECK(i >= 2 || (r.acute_edges == 1 && fabs(r.least_angle - 20) < 1e-9));
        test_say("%zu tetrahedra %.2f..%.2f, volume %.3g off, %zu acute edges, least %.3f", mesh.tet_count,
                 r.improve.after.least, r.improve.after.largest, r.improve.after.volume - volume, r.acute_edges,
                 r.least_angle);
        pbw_tets_free(&mesh);
    }
    test_end();
}

static void test_models(void)
{
    static model m;
    pbw_solid_input in;
    double volume;
    int turned;
    for (turned = 0; turned < 2; turned++) {
        if (test_begin("models%s", turned ? ", turned" : "")) {
            volume = make_hole(&m);
            if (turned) {
                turn(&m);
            }
            in = input_of(&m);
            check_good(&in, 0.1, volume, 0, 24);
            volume = make_l(&m);
            if (turned) {
                turn(&m);
            }
            in = input_of(&m);
            check_good(&in, 0.2, volume, 2, 24);
            test_end();
        }
    }
}

static double hollow_above(const double p[3])
{
    return -hollow(NULL, p);
}

/* Isosurface stuffing: facets fit, the boundary is two spheres, the angles are those that are proven. */
static void test_stuffing(void)
{
    pbw_improve_options how;
    pbw_improve_report r;
    pbwst_mesh made;
    pbw_tets in, out;
    pbwm3__topology top;
    pbwsf__memory memory = pbwsf__memory_of(NULL);
    pbw_index *facets;
    size_t count = 0, i;
    int k;
    if (!test_begin("stuffing")) {
        return;
    }
    memset(&in, 0, sizeof in);
    memset(&how, 0, sizeof how);
    how.passes = -1;
    CHECK(pbwst_make(21, -1.2, 1.2, hollow_above, &made));
    in.points = made.x[0];
    in.point_count = made.points;
    in.corners = made.corners;
    in.tet_count = made.tets;
    CHECK_EQUAL(pbw_improve(&in, &how, NULL, &out, &r), PBW_OK);
    CHECK(r.turned == 0 && is_sound(&out));
    CHECK(r.after.least > 10.7 && r.after.largest < 164.8);
    CHECK(fabs(r.after.volume - 4 * PI / 3 * 0.875) < 0.05);
    facets = (pbw_index *)zoo_grow(NULL, 48 * out.tet_count);
    for (i = 0; i < 4 * out.tet_count; i++) {
        for (k = 0; k < 3 && out.neighbors[i] == PBW_NONE; k++) {
            facets[count++] = out.corners[i / 4 * 4 + (size_t)pbwim__opposite[i % 4][k]];
        }
    }
    CHECK(pbwm3__examine(&memory, facets, count / 3, out.point_count, &top));
    CHECK_EQUAL(top.bad_edges + top.bad_points, 0);
    CHECK_EQUAL(top.euler, 4);
    pbwsf__release(&memory, &top.edges);
    pbwsf__release(&memory, &top.flags);
    free(facets);
    pbw_tets_free(&out);
    pbwst_free(&made);
    test_end();
}

/* A plate in the shape of an L, less than a third as thick as the size, turned. */
static void test_thin(void)
{
    static model m;
    pbw_solid_input in;
    size_t i;
    if (test_begin("thin plate, turned")) {
        make_l(&m);
        for (i = 0; i < m.points; i++) {
            m.x[i][2] *= 0.1;
        }
        turn(&m);
        in = input_of(&m);
        check_good(&in, 0.35, 0.3, 2, 20);
        test_end();
    }
}

/* An L's corners and edges are on the mesh: its volume is right to rounding. */
static void test_features(void)
{
    static model m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    if (!test_begin("features")) {
        return;
    }
    make_l(&m);
    in = input_of(&m);
    memset(&how, 0, sizeof how);
    how.size = 0.25;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &r), PBW_OK);
    CHECK_EQUAL(r.corners, 12);
    CHECK_EQUAL(r.sharp_edges, 18);
    CHECK(fabs(r.improve.after.volume - 3) < 1e-12 && fabs(r.input_volume - 3) < 1e-12);
    CHECK(r.distance < 1e-12);
    pbw_tets_free(&mesh);
    test_end();
}

/* Open, crowded, empty and random input: counted, or refused, and it ends. */
static void test_warnings(void)
{
    static model m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    pbw_status status;
    int i, k;
    if (!test_begin("warnings")) {
        return;
    }
    memset(&how, 0, sizeof how);
    how.size = 0.3;
    make_l(&m);
    m.triangles -= 1;
    in = input_of(&m);
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &r), PBW_OK);
    CHECK_EQUAL(r.open_edges, 3);
    CHECK(is_sound(&mesh));
    pbw_tets_free(&mesh);
    m.triangles = 1;
    in = input_of(&m);
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &r), PBW_DEGENERATE);
    in.triangle_count = 0;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &r), PBW_DEGENERATE);
    for (i = 0; i < 6; i++) {                        /* a soup */
        for (k = 0; k < 60; k++) {
            m.x[k / 3][k % 3] = fmod(sin((double)(60 * i + k) + 1 + (double)test_seed) * 4375.85453, 1);
            m.t[k / 3][k % 3] = (pbw_index)((k * (7 + i) + k / 3) % 20);
        }
        m.points = m.triangles = 20;
        in = input_of(&m);
        how.rounds = 4;
        how.size = 0.5;
        how.improve.passes = 2;
        status = pbw_solid(&in, &how, NULL, &mesh, &r);
        CHECK(status == PBW_OK || status == PBW_DEGENERATE);
        CHECK(status != PBW_OK || (is_sound(&mesh) && r.open_edges + r.crowded_edges > 0));
        pbw_tets_free(&mesh);
    }
    m.t[3][1] = 77777;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &r), PBW_ERROR_ARGUMENT);
    m.t[3][1] = 0;
    m.x[3][1] = HUGE_VAL;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &r), PBW_ERROR_NOT_FINITE);
    m.x[3][1] = 0;
    how.size = 1e-9;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &r), PBW_ERROR_TOO_LARGE);
    test_end();
}

static void test_failures(void)
{
    static model m;
    pbw_options options;
    pbw_solid_options how;
    pbw_solid_input in;
    pbw_tets mesh;
    pbw_status status = PBW_ERROR_MEMORY;
    meter memory;
    watch w;
    long k;
    if (!test_begin("failing allocations, cancelling")) {
        return;
    }
    make_l(&m);
    in = input_of(&m);
    memset(&options, 0, sizeof options);
    memset(&how, 0, sizeof how);
    how.size = 1.2;
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &memory;
    for (k = 1; status == PBW_ERROR_MEMORY && k < 5000; k++) {
        meter_start(&memory, k, 1);
        status = pbw_solid(&in, &how, &options, &mesh, NULL);
        CHECK(status == PBW_ERROR_MEMORY || mesh.tet_count > 0);
        pbw_tets_free(&mesh);
        CHECK(memory.blocks == 0 && memory.faults == 0);
    }
    CHECK(k > 50 && status == PBW_OK);
    meter_start(&memory, 0, 0);
    options.progress = watch_progress;
    options.progress_user = &w;
    for (k = 1, status = PBW_CANCELLED; status == PBW_CANCELLED && k < 1000; k++) {
        watch_start(&w, k);
        status = pbw_solid(&in, &how, &options, &mesh, NULL);
        CHECK(w.wrong == 0);
        CHECK(status == PBW_OK || mesh.points == NULL);
        pbw_tets_free(&mesh);
        CHECK(memory.blocks == 0);
    }
    CHECK(k > 5 && status == PBW_OK);
    test_end();
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 1);
    test_functions();
    test_models();
    test_features();
    test_acute();
    test_thin();
    test_stuffing();
    test_warnings();
    test_failures();
    return test_finish();
}
