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

static pbw_solid_input input_of(const part *m)
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

/* Four threads make the mesh that one made. */
static int is_same(const pbw_tets *a, const pbw_tets *b)
{
    return a->tet_count == b->tet_count && a->point_count == b->point_count
        && memcmp(a->corners, b->corners, 16 * a->tet_count) == 0
        && memcmp(a->points, b->points, 24 * a->point_count) == 0;
}

static void check_threads(const pbw_solid_input *in, const pbw_solid_options *how, const pbw_tets *mesh)
{
    pbw_options threads;
    pbw_tets other;
    memset(&threads, 0, sizeof threads);
    threads.threads = 4;
    CHECK_EQUAL(pbw_solid(in, how, &threads, &other, NULL, NULL), PBW_OK);
    CHECK(is_same(mesh, &other));
    pbw_tets_free(&other);
}

/* A solid with a known volume: settled, a manifold, near the surface, good angles; if bidden, by threads too. */
static void check_good(const pbw_solid_input *in, double size, double volume, long euler, double least, int threaded)
{
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_options threads;
    pbw_tets mesh;
    memset(&how, 0, sizeof how);
    memset(&threads, 0, sizeof threads);
    how.size = size;
    threads.threads = 1;
    CHECK_EQUAL(pbw_solid(in, &how, &threads, &mesh, NULL, &r), PBW_OK);
    CHECK(is_sound(&mesh));
    CHECK_EQUAL(r.settled, 1);
    CHECK_EQUAL(r.bad_edges + r.bad_points + r.missing_edges + r.open_edges + r.crowded_edges, 0);
    CHECK_EQUAL(r.euler, euler);
    CHECK(fabs(r.improve.after.volume - volume) < (size > 0.2 ? 0.06 : 0.03) * volume);
    CHECK(r.distance <= 0.15);
    CHECK(r.improve.after.least > least && r.improve.after.largest < 180 - least);
    if (r.bad_edges + r.bad_points + r.missing_edges > 0) {
        test_say("%zu bad edges, %zu bad points, %zu missing edges", r.bad_edges, r.bad_points, r.missing_edges);
        test_say("first at %.9g %.9g %.9g", r.places[0][0], r.places[0][1], r.places[0][2]);
    }
    test_say("%zu tetrahedra %.2f..%.2f, distance %.3f, volume %.5f of %.5f, %d rounds", mesh.tet_count,
             r.improve.after.least, r.improve.after.largest, r.distance, r.improve.after.volume, volume, r.rounds);
    if (threaded) {
        check_threads(in, &how, &mesh);
    }
    pbw_tets_free(&mesh);
}

static void test_functions(void)
{
    pbw_solid_input in;
    if (test_begin("functions")) {
        in = input_by(sphere);
        check_good(&in, 0.2, 4 * PARTS_PI / 3, 2, 28, 0);
        in = input_by(hollow);
        check_good(&in, 0.15, 4 * PARTS_PI / 3 * 0.875, 4, 26, 1);
        in = input_by(torus);
        check_good(&in, 0.15, 2 * PARTS_PI * PARTS_PI * 0.1225, 0, 26, 0);
        check_good(&in, 0.24, 2 * PARTS_PI * PARTS_PI * 0.1225, 0, 26, 0);   /* edges across the hole bend the most */
        check_good(&in, 0.3, 2 * PARTS_PI * PARTS_PI * 0.1225, 0, 26, 0);
        test_end();
    }
}

/* Edges at few points, in groups of hundreds, sorted by any number of threads: each once, by both ends, then by
   triangles. */
static void test_edges(void)
{
    enum { POINTS = 40, TRIANGLES = 5000 };
    static pbw_index triangles[3 * TRIANGLES];
    static unsigned char seen[3 * TRIANGLES];
    pbwim__sorting sorting;
    pbwm3__work w;
    size_t i;
    int count;
    if (!test_begin("edges")) {
        return;
    }
    for (i = 0; i < 3 * TRIANGLES; i++) {            /* three different corners */
        triangles[i] = (pbw_index)(i % 3 == 0 ? pbw_random(1, i) % POINTS
                                   : (triangles[i - 1] + 1 + pbw_random(1, i) % (POINTS / 2 - 1)) % POINTS);
    }
    for (count = 1; count < 4; count++) {
        const pbwim__facet *e;
        int right = 1;
        memset(&w, 0, sizeof w);
        memset(seen, 0, sizeof seen);
        pbw_memory_start(&w.memory, NULL);
        w.options.threads = count;
        e = pbwm3__edges(&w, triangles, TRIANGLES, POINTS, &sorting);
        for (i = 0; i < 3 * TRIANGLES; i++, e++) {
            const pbw_index *c = triangles + 3 * (size_t)e->t, a = c[e->i], b = c[(e->i + 1) % 3];
            right &= e->v[0] == (a < b ? a : b) && e->v[1] == (a < b ? b : a) && e->v[2] == (pbw_index)(a < b)
                  && !seen[3 * (size_t)e->t + (size_t)e->i];
            seen[3 * (size_t)e->t + (size_t)e->i] = 1;
            right &= i == 0 || e[-1].v[0] < e->v[0]
                  || (e[-1].v[0] == e->v[0] && (e[-1].v[1] < e->v[1] || (e[-1].v[1] == e->v[1] && e[-1].t < e->t)));
        }
        CHECK(right);
        pbwim__end_sorting(&w.memory, &sorting);
    }
    test_end();
}

/* Any number of threads makes the same mesh, boundary and report: a hollow ball, which has two shells. */
static void test_threads(void)
{
    const pbw_solid_input in = input_by(hollow);
    static const int counts[] = { 1, 2, 3, 8 };
    pbw_solid_boundary boundary[2];
    pbw_solid_report r[2];
    pbw_solid_options how;
    pbw_options threads;
    pbw_tets mesh[2];
    size_t i;
    if (!test_begin("threads")) {
        return;
    }
    memset(&how, 0, sizeof how);
    memset(&threads, 0, sizeof threads);
    how.size = 0.13;
    for (i = 0; i < 4; i++) {
        const size_t at = i > 0;
        threads.threads = counts[i];
        CHECK_EQUAL(pbw_solid(&in, &how, &threads, mesh + at, boundary + at, r + at), PBW_OK);
        CHECK(mesh->tet_count == mesh[at].tet_count && mesh->point_count == mesh[at].point_count
              && memcmp(mesh->corners, mesh[at].corners, 16 * mesh->tet_count) == 0
              && memcmp(mesh->points, mesh[at].points, 24 * mesh->point_count) == 0
              && memcmp(mesh->regions, mesh[at].regions, 4 * mesh->tet_count) == 0);
        CHECK(boundary->facet_count == boundary[at].facet_count
              && memcmp(boundary->facets, boundary[at].facets, 12 * boundary->facet_count) == 0
              && memcmp(boundary->patches, boundary[at].patches, 4 * boundary->facet_count) == 0);
        CHECK(memcmp(&r->distance, &r[at].distance, sizeof r->distance) == 0
              && memcmp(&r->estimate, &r[at].estimate, sizeof r->estimate) == 0);
        if (at > 0) {
            pbw_tets_free(mesh + 1);
            pbw_solid_boundary_free(boundary + 1);
        }
    }
    test_say("%zu tetrahedra", mesh->tet_count);
    pbw_tets_free(mesh);
    pbw_solid_boundary_free(boundary);
    test_end();
}

/* Returns the largest distance of triangles from others, of middles, middles of edges, and corners. */
static double farthest(const double *points, const pbw_index *triangles, size_t count,
                       const double *others, size_t other_count, const pbw_index *from, size_t from_count)
{
    pbw_surface surface;
    double most = 0;
    size_t i;
    int k, j;
    CHECK_EQUAL(pbw_surface_create(others, other_count, from, from_count, NULL, &surface), PBW_OK);
    for (i = 0; i < count; i++) {
        for (k = 0; k < 7; k++) {
            double p[3], place[3];
            for (j = 0; j < 3; j++) {
                const double a = points[3 * triangles[3 * i + (size_t)(k % 3)] + (size_t)j];
                const double b = points[3 * triangles[3 * i + (size_t)((k + 1) % 3)] + (size_t)j];
                const double c = points[3 * triangles[3 * i + (size_t)((k + 2) % 3)] + (size_t)j];
                p[j] = k < 3 ? a : k < 6 ? (a + b) / 2 : (a + b + c) / 3;
            }
            (void)pbw_surface_closest(&surface, p, HUGE_VAL, place);
            most = fmax(most, pbwsf__distance(p, place));
        }
    }
    pbw_surface_free(&surface);
    return most;
}

/* The report's distance is the larger one of both ways, though it searches only where one can be larger. */
static void test_distance(void)
{
    static part m;
    pbw_solid_boundary b;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    int shape;
    if (!test_begin("the report's distance")) {
        return;
    }
    memset(&how, 0, sizeof how);
    how.improve.target = -1;
    for (shape = 0; shape < 3; shape++) {
        static const size_t shapes[3] = { PART_BALL, 2, 14 };
        double there, back;
        (void)part_make(shapes[shape], 1, &m);
        how.size = 2 * parts[shapes[shape]].size;
        in = input_of(&m);
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &b, &r), PBW_OK);
        there = farthest(mesh.points, b.facets, b.facet_count, in.points, in.point_count,
                         in.triangles, in.triangle_count);
        back = farthest(in.points, in.triangles, in.triangle_count, mesh.points, mesh.point_count,
                        b.facets, b.facet_count);
        test_say("%.6f there, %.6f back, %.6f reported", there / r.size, back / r.size, r.distance);
        CHECK(fabs(fmax(there, back) - r.distance * r.size) < 1e-12);
        pbw_tets_free(&mesh);
        pbw_solid_boundary_free(&b);
    }
    test_end();
}

/* The part becomes a box. */
static void make_box(part *m, const double low[3], const double high[3])
{
    m->points = m->triangles = 0;
    (void)part_box(m, low, high, 0);
}

/* Makes the solid of a part, which must be sound, with a boundary that is a manifold. */
static void make_solid(const part *m, const pbw_solid_options *how, pbw_tets *mesh, pbw_solid_report *r)
{
    pbw_solid_input in = input_of(m);
    CHECK_EQUAL(pbw_solid(&in, how, NULL, mesh, NULL, r), PBW_OK);
    CHECK(is_sound(mesh) && r->bad_edges + r->bad_points == 0);
    test_say("%zu tetrahedra %.2f..%.2f, volume %.4f of %.4f, distance %.3f", mesh->tet_count, r->improve.after.least,
             r->improve.after.largest, r->improve.after.volume, r->input_volume, r->distance);
}

/* Two pyramids or cones, base to base. */
static void make_bipyramid(part *m, size_t sides, double radius, double height)
{
    const double step = 2 * PARTS_PI / (double)sides;
    size_t i;
    m->points = m->triangles = 0;
    for (i = 0; i < sides; i++) {
        (void)part_point(m, radius * cos(step * (double)i), radius * sin(step * (double)i), 0);
    }
    (void)part_point(m, 0, 0, -height);
    (void)part_point(m, 0, 0, height);
    for (i = 0; i < sides; i++) {
        part_triangle(m, (i + 1) % sides, i, sides);
        part_triangle(m, i, (i + 1) % sides, sides + 1);
    }
}

/* Two cones, base to base, with tips thinner than a third of the size: the boundary comes near them. */
static void test_horns(void)
{
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    size_t tets;
    if (!test_begin("tips thinner than the size")) {
        return;
    }
    make_bipyramid(&m, 32, 0.5, 2.5);
    in = input_of(&m);
    memset(&how, 0, sizeof how);
    how.size = 0.4;
    make_solid(&m, &how, &mesh, &r);
    CHECK(r.settled && r.euler == 2 && r.distance < 0.45 && r.improve.after.least > 28);
    check_threads(&in, &how, &mesh);
    tets = mesh.tet_count;
    pbw_tets_free(&mesh);
    how.least_size = 0.4 / 3;                        /* no size below it, at tips either */
    make_solid(&m, &how, &mesh, &r);
    CHECK(mesh.tet_count < tets && r.distance < 0.45 && r.improve.after.least > 27);
    pbw_tets_free(&mesh);
    test_end();
}

/* Points that stay at tips and ridges spoil tetrahedra there, of 23 degrees; these points are let go. */
static void test_tips_let_go(void)
{
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_tets mesh;
    if (!test_begin("tips that spoil tetrahedra")) {
        return;
    }
    make_bipyramid(&m, 3, 0.5, 2);
    memset(&how, 0, sizeof how);
    how.sharp = PBW_SOLID_SHARP_NONE;
    how.size = 0.16;
    make_solid(&m, &how, &mesh, &r);
    CHECK_EQUAL(r.improve.left, 0);
    CHECK(r.euler == 2 && r.improve.after.least > 29.9 && r.distance < 0.4);
    pbw_tets_free(&mesh);
    test_end();
}

/* A box of which no sharp edge is kept: points on its creases and at their corners keep the boundary near. */
static void test_creases(void)
{
    static const double low[3] = { 0, 0, 0 }, high[3] = { 1, 0.8, 0.7 };
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_tets mesh;
    int i;
    if (!test_begin("creases and their corners")) {
        return;
    }
    make_box(&m, low, high);
    memset(&how, 0, sizeof how);
    how.sharp = PBW_SOLID_SHARP_NONE;
    for (i = 1; i < 4; i++) {
        how.size = 0.1 * i;
        make_solid(&m, &how, &mesh, &r);
        CHECK(r.euler == 2 && r.sharp_edges == 0 && r.distance < 0.15 && r.improve.after.least > 29);
        pbw_tets_free(&mesh);
    }
    test_end();
}

/* Faces that lie in one plane but for rounding, so that few of their triangles cross: boxes on a cone, of which the
   tip is below.  A union with too few cuts loses a box, or its pieces overlap. */
static void test_nearly_common_faces(void)
{
    static const double line[3][2] = { { 0, 0 }, { 0.8, 0.9 }, { 0, 0.9 } };
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_tets mesh;
    int i;
    if (!test_begin("faces in one plane but for rounding")) {
        return;
    }
    memset(&how, 0, sizeof how);
    how.size = 0.4;
    how.improve.target = -1;
    for (i = 4; i < 8; i++) {
        const double low[3] = { 0.05 * i - 0.3, -0.6, 0.9 }, high[3] = { 0.05 * i + 0.9, 0.6, 1.9 };
        double volume;
        m.points = m.triangles = 0;
        volume = part_turned(&m, 3, line, 16, 0);
        volume += part_box(&m, low, high, 0);
        part_turn(&m);
        make_solid(&m, &how, &mesh, &r);
        CHECK(fabs(r.improve.after.volume - volume) < 0.02 * volume && r.missing_edges < 10);
        CHECK(fabs(r.input_volume - volume) < 1e-6);
        pbw_tets_free(&mesh);
    }
    test_end();
}

/* Sharp edges that other labels take from the boundary are missing in the report. */
static void test_missing(void)
{
    static const double low[3] = { 0, 0, 0 }, high[3] = { 1, 1, 1 };
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbwm3__call call;
    pbwm3__work w;
    size_t t;
    if (!test_begin("sharp edges lost by other labels")) {
        return;
    }
    make_box(&m, low, high);
    in = input_of(&m);
    memset(&how, 0, sizeof how);
    memset(&call, 0, sizeof call);
    how.size = 0.3;
    call.input = &in;
    call.how = &how;
    call.deadline = HUGE_VAL;
    CHECK_EQUAL(pbwm3__attempt(&call, 0, PBW_SOLID_SHARP_AUTO, 0, &r, &w), PBW_OK);
    CHECK_EQUAL(r.missing_edges, 0);
    for (t = 0; t < 4 * w.now.mesh.simplex_count; t++) {         /* of all tetrahedra at one end of a piece */
        if (w.now.mesh.simplices[t] == w.pieces.at[0].a) {
            w.now.label.at[t / 4] = 0;
        }
    }
    CHECK_EQUAL(pbwm3__make_manifold(&w), PBW_OK);
    CHECK(r.missing_edges > 0);
    test_say("%zu of %zu pieces are missing", r.missing_edges, w.pieces.count);
    pbwm3__free(&w);
    test_end();
}

/* Two boxes with a gap of 1/30 of the size between them stay apart; a thin wall of a hollow box is no gap. */
static void test_gaps(void)
{
    static const double low[3][3] = { { 0, 0, 0 }, { 0.52, 0, 0 }, { 0.1, 0.02, 0.1 } };
    static const double high[3][3] = { { 0.5, 0.5, 0.5 }, { 1, 0.5, 0.5 }, { 0.4, 0.4, 0.4 } };
    static part m;
    pbw_solid_input in;
    if (!test_begin("gaps between shells")) {
        return;
    }
    m.points = m.triangles = 0;
    (void)part_box(&m, low[0], high[0], 0);
    (void)part_box(&m, low[1], high[1], 0);
    in = input_of(&m);
    check_good(&in, 0.6, 0.125 + 0.48 * 0.25, 4, 25, 1);
    m.points = m.triangles = 0;                      /* a wall, not a gap: no size is below 1/6 */
    (void)part_box(&m, low[0], high[0], 0);
    (void)part_box(&m, low[2], high[2], 1);
    in = input_of(&m);
    check_good(&in, 0.1, 0.125 - 0.3 * 0.38 * 0.3, 4, 20, 0);
    test_end();
}

/* A cone of many sides: no edge at its tip is sharp, and darts miss it; the boundary reaches it. */
static void test_tip(void)
{
    static part m;
    const size_t sides = 24;
    const double step = 2 * PARTS_PI / (double)sides;
    pbw_solid_input in;
    size_t i;
    if (!test_begin("tips between smooth edges")) {
        return;
    }
    m.points = m.triangles = 0;
    for (i = 0; i < sides; i++) {
        (void)part_point(&m, cos(step * (double)i), sin(step * (double)i), 0);
    }
    (void)part_point(&m, 0, 0, 0);
    (void)part_point(&m, 0, 0, 1.7);
    for (i = 0; i < sides; i++) {
        part_triangle(&m, i, sides, (i + 1) % sides);
        part_triangle(&m, i, (i + 1) % sides, sides + 1);
    }
    in = input_of(&m);
    check_good(&in, 0.15, (double)sides / 2 * sin(step) * 1.7 / 3, 2, 28, 0);
    test_end();
}

/* A ball with a horn and a pit that are thinner than tetrahedra: the boundary reaches both ends. */
static void test_pits(void)
{
    static part m;
    double line[61][2];
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    size_t k;
    if (!test_begin("horns and pits thinner than tetrahedra")) {
        return;
    }
    for (k = 0; k < 61; k++) {
        line[k][0] = k % 60 == 0 ? 0 : sin(PARTS_PI * (double)k / 60);
        line[k][1] = k == 0 ? -0.7 : k == 60 ? 1.2 : -cos(PARTS_PI * (double)k / 60);
    }
    m.points = m.triangles = 0;
    (void)part_turned(&m, 61, (const double (*)[2])line, 24, 0);
    in = input_of(&m);
    memset(&how, 0, sizeof how);
    how.size = 0.2;
    how.sharp = PBW_SOLID_SHARP_NONE;
    make_solid(&m, &how, &mesh, &r);
    CHECK(r.euler == 2 && r.distance < 0.2 && r.improve.after.least > 28);
    check_threads(&in, &how, &mesh);
    pbw_tets_free(&mesh);
    test_end();
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
    for (i = 0; i < 5; i++) {
        const size_t number = i < 2 || i == 4 ? PART_WEDGE : PART_SPIKE;
        const double volume = part_make(number, i % 2 || i == 4, &m);
        memset(&how, 0, sizeof how);
        in = input_of(&m);
        how.size = i == 4 ? 0.2 : 0.1;               /* smooth points lie on sharp edges there, and go */
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
        CHECK(is_sound(&mesh));
        CHECK_EQUAL(r.settled, 1);
        CHECK_EQUAL(r.bad_edges + r.bad_points + r.missing_edges, 0);
        CHECK_EQUAL(r.euler, 2);
        CHECK(fabs(r.improve.after.volume - volume) < 1e-12 && r.distance < 1e-12);
        CHECK(r.improve.after.least > (i < 2 ? 18 : i < 4 ? 28 : 15));
        CHECK((i >= 2 && i < 4) || (r.acute_edges == 1 && fabs(r.least_angle - 20) < 1e-9));
        test_say("%zu tetrahedra %.2f..%.2f, volume %.3g off, %zu acute edges, least %.3f", mesh.tet_count,
                 r.improve.after.least, r.improve.after.largest, r.improve.after.volume - volume, r.acute_edges,
                 r.least_angle);
        pbw_tets_free(&mesh);
    }
    test_end();
}

static void test_models(void)
{
    static part m;
    pbw_solid_input in;
    double volume;
    int turned;
    for (turned = 0; turned < 2; turned++) {
        if (test_begin("models%s", turned ? ", turned" : "")) {
            volume = part_make(PART_HOLE, turned, &m);
            in = input_of(&m);
            check_good(&in, 0.1, volume, 0, 24, turned);
            volume = part_make(PART_L, turned, &m);
            in = input_of(&m);
            check_good(&in, 0.2, volume, 2, 24, !turned);
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
    pbwm3__work w;
    pbw_index *facets;
    size_t count = 0, i;
    int k;
    if (!test_begin("stuffing")) {
        return;
    }
    memset(&in, 0, sizeof in);
    memset(&how, 0, sizeof how);
    how.passes = -1;
    CHECK_EQUAL(pbwst_make(21, -1.2, 1.2, hollow_above, NULL, &made), PBW_OK);
    in.points = made.x[0];
    in.point_count = made.points;
    in.corners = made.corners;
    in.tet_count = made.tets;
    CHECK_EQUAL(pbw_improve(&in, &how, NULL, &out, &r), PBW_OK);
    CHECK(r.turned == 0 && is_sound(&out));
    CHECK(r.after.least > 10.7 && r.after.largest < 164.8);
    CHECK(fabs(r.after.volume - 4 * PARTS_PI / 3 * 0.875) < 0.05);
    facets = (pbw_index *)zoo_grow(NULL, 48 * out.tet_count);
    for (i = 0; i < 4 * out.tet_count; i++) {
        for (k = 0; k < 3 && out.neighbors[i] == PBW_NONE; k++) {
            facets[count++] = out.corners[i / 4 * 4 + (size_t)pbwim__opposite[i % 4][k]];
        }
    }
    memset(&w, 0, sizeof w);
    pbw_memory_start(&w.memory, NULL);
    CHECK(pbwm3__examine(&w, facets, count / 3, out.point_count, &top));
    CHECK_EQUAL(top.bad_edges + top.bad_points, 0);
    CHECK_EQUAL(top.euler, 4);
    PBW_RELEASE(&w.memory, top.edges);
    PBW_RELEASE(&w.memory, top.flags);
    free(facets);
    pbw_tets_free(&out);
    pbwst_free(&made);
    test_end();
}

static int stop_soon(void *calls, pbw_stage stage, double done)
{
    return ++*(int *)calls == 9 || stage != PBW_STAGE_WORK || !(done >= 0 && done <= 1);
}

/* Each allocation fails once, limits hold, progress cancels, arguments are refused: nothing is left or leaks. */
static void test_stuffing_fails(void)
{
    static const pbwst_mesh none;
    pbw_options options;
    pbw_status status;
    pbwst_mesh made;
    meter m;
    size_t peak = 0, tets = 0;
    int calls = 0, k;
    if (!test_begin("stuffing: memory, limits, cancelling")) {
        return;
    }
    for (k = 0; k <= 1 || m.refused > 0; k++) {          /* 0: none fails */
        memset(&options, 0, sizeof options);
        meter_start(&m, k, 0);
        options.resize = meter_resize;
        options.resize_user = &m;
        status = pbwst_make(12, -1.2, 1.2, hollow_above, &options, &made);
        CHECK(status == (m.refused ? PBW_ERROR_MEMORY : PBW_OK));
        CHECK(m.refused ? memcmp(&made, &none, sizeof made) == 0 : made.tets > 100 && (k == 0 || made.tets == tets));
        peak = k == 0 ? m.peak : peak;
        tets = k == 0 ? made.tets : tets;
        pbwst_free(&made);
        pbwst_free(&made);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    CHECK(k > 4);
    for (k = 1; k <= 20; k++) {
        meter_start(&m, 0, 0);
        options.memory_limit = peak * (size_t)k / 10;
        status = pbwst_make(12, -1.2, 1.2, hollow_above, &options, &made);
        CHECK(status == (k < 10 ? PBW_ERROR_MEMORY : PBW_OK));
        CHECK(m.peak <= options.memory_limit);
        pbwst_free(&made);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    options.progress = stop_soon;
    options.progress_user = &calls;
    CHECK_EQUAL(pbwst_make(12, -1.2, 1.2, hollow_above, &options, &made), PBW_CANCELLED);
    CHECK(calls == 9 && m.blocks == 0);
    CHECK_EQUAL(pbwst_make(3, -1, 1, hollow_above, NULL, &made), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwst_make(201, -1, 1, hollow_above, NULL, &made), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwst_make(9, 1, 1, hollow_above, NULL, &made), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwst_make(9, -1, 1, NULL, NULL, &made), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwst_make(9, -1, 1, hollow_above, NULL, NULL), PBW_ERROR_ARGUMENT);
    test_end();
}

/* A plate in the shape of an L, less than a third as thick as the size, turned. */
static void test_thin(void)
{
    static part m;
    pbw_solid_input in;
    size_t i;
    if (test_begin("thin plate, turned")) {
        (void)part_make(PART_L, 0, &m);
        for (i = 0; i < m.points; i++) {
            m.x[i][2] *= 0.1;
        }
        part_turn(&m);
        in = input_of(&m);
        check_good(&in, 0.35, 0.3, 2, 20, 1);
        test_end();
    }
}

/* Returns the length of the longest edge. */
static double longest_edge(const pbw_tets *t)
{
    double longest = 0;
    size_t i;
    int a, b;
    for (i = 0; i < t->tet_count; i++) {
        for (a = 0; a < 4; a++) {
            for (b = 0; b < a; b++) {
                longest = fmax(longest, pbwsf__distance(t->points + 3 * (size_t)t->corners[4 * i + (size_t)a],
                                                        t->points + 3 * (size_t)t->corners[4 * i + (size_t)b]));
            }
        }
    }
    return longest;
}

/* A thin plate is found thin in each of its 676 squares of the size: no edge is longer than twice its local size. */
static void test_plate(void)
{
    static const double low[3] = { 0, 0, 0 }, high[3] = { 26, 26, 0.3 };
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    if (!test_begin("thin plate, large")) {
        return;
    }
    make_box(&m, low, high);
    in = input_of(&m);
    memset(&how, 0, sizeof how);
    how.size = 1;
    how.improve.target = -1;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
    test_say("longest edge %.3f, %zu tetrahedra", longest_edge(&mesh), mesh.tet_count);
    CHECK(longest_edge(&mesh) < 2 * 1.33 * 0.3);
    pbw_tets_free(&mesh);
    test_end();
}

/* An L's corners and edges are on the mesh: its volume is right to rounding. */
static void test_features(void)
{
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    if (!test_begin("features")) {
        return;
    }
    (void)part_make(PART_L, 0, &m);
    in = input_of(&m);
    memset(&how, 0, sizeof how);
    how.size = 0.25;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
    CHECK_EQUAL(r.corners, 12);
    CHECK_EQUAL(r.sharp_edges, 18);
    CHECK(fabs(r.improve.after.volume - 3) < 1e-12 && fabs(r.input_volume - 3) < 1e-12);
    CHECK(r.distance < 1e-12);
    pbw_tets_free(&mesh);
    test_end();
}

/* Volume of a region, and whether facets between regions and outside are what `sides` says. */
static double volume_of(const pbw_tets *t, pbw_index region)
{
    double volume = 0;
    size_t i;
    for (i = 0; i < t->tet_count; i++) {
        const pbw_index *c = t->corners + 4 * i;
        volume += t->regions[i] == region
                ? pbw_tet_measure(PBW_MEASURE_VOLUME, t->points + 3 * (size_t)c[0], t->points + 3 * (size_t)c[1],
                                  t->points + 3 * (size_t)c[2], t->points + 3 * (size_t)c[3]) : 0;
    }
    return volume;
}

/* Facets lie where their corner's tetrahedron says, on the sides of two regions, and enclose their volumes. */
static int is_boundary(const pbw_tets *t, const pbw_solid_boundary *b, pbw_index region, double volume)
{
    double sum = 0;
    size_t i, k, j, right = 0;
    for (i = 0; i < b->facet_count; i++) {
        const pbw_index *f = b->facets + 3 * i, at = b->corners[i];
        const double *p[3];
        double n[3];
        int side = b->sides[2 * i] == region ? 1 : b->sides[2 * i + 1] == region ? -1 : 0;
        for (k = 0, j = 0; k < 3; k++) {
            p[k] = t->points + 3 * (size_t)f[k];
            j += f[k] != t->corners[at] && (f[k] == t->corners[at / 4 * 4] || f[k] == t->corners[at / 4 * 4 + 1]
                                            || f[k] == t->corners[at / 4 * 4 + 2]
                                            || f[k] == t->corners[at / 4 * 4 + 3]);
        }
        right += j == 3 && t->regions[at / 4] == b->sides[2 * i];
        pbwsf__cross(p[1], p[2], n);
        sum += side * pbwsf__dot(p[0], n) / 6;
    }
    return right == b->facet_count && fabs(sum - volume) < 1e-9;
}

/* A box in a box: a cavity, or two regions; and boxes apart. */
static void test_regions(void)
{
    static const double at[3][3] = { { 0, 0, 0 }, { 0.3, 0.3, 0.3 }, { 2, 0, 0 } }, end[3] = { 1, 0.7, 2.5 };
    static part m;
    pbw_solid_options how;
    pbw_solid_boundary boundary;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    int turned, nested, i;
    if (!test_begin("regions")) {
        return;
    }
    for (turned = 0; turned < 2; turned++) {
        for (nested = 0; nested < 2; nested++) {
            const double volumes[3] = { 1 - 0.064, nested ? 0.064 : 0, 0.125 };
            m.points = m.triangles = 0;
            for (i = 0; i < 3; i++) {
                const double side = end[i] - at[i][0];
                const double high[3] = { end[i], at[i][1] + side, at[i][2] + side };
                (void)part_box(&m, at[i], high, i == 2);         /* one is turned inside out */
            }
            if (turned) {
                part_turn(&m);
            }
            in = input_of(&m);
            memset(&how, 0, sizeof how);
            how.size = 0.2;
            how.nested = nested;
            CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &boundary, &r), PBW_OK);
            CHECK(is_sound(&mesh));
            CHECK_EQUAL(r.bad_edges + r.bad_points + r.missing_edges, 0);
            CHECK(r.shells == 3 && r.regions == (nested ? 3u : 2u) && r.euler == 6);
            CHECK(fabs(r.input_volume - (nested ? 1.125 : 1.061)) < 1e-12);
            for (i = 0; i < 3; i++) {
                CHECK(fabs(volume_of(&mesh, (pbw_index)i) - volumes[i]) < 1e-9);
                CHECK(is_boundary(&mesh, &boundary, (pbw_index)i, volumes[i]));
            }
            test_say("%zu tetrahedra, %.2f..%.2f", mesh.tet_count, r.improve.after.least, r.improve.after.largest);
            pbw_solid_boundary_free(&boundary);
            pbw_tets_free(&mesh);
        }
    }
    test_end();
}

/* Unit cubes side by side, their walls given once or with each cube.  Returns how many walls are between two. */
static size_t make_cubes(part *m, const size_t n[3], int twice)
{
    static const int corner[6][4] = { { 0, 2, 3, 1 }, { 4, 5, 7, 6 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 }, { 0, 4, 6, 2 },
                                      { 1, 3, 7, 5 } };
    const size_t count = n[0] * n[1] * n[2], wide = n[0] + 1, deep = n[1] + 1;
    size_t i, k, at[8], walls = 0;
    m->points = m->triangles = 0;
    for (i = 0; i < wide * deep * (n[2] + 1) && !twice; i++) {
        (void)part_point(m, (double)(i % wide), (double)(i / wide % deep), (double)(i / wide / deep));
    }
    for (i = 0; i < count; i++) {
        const size_t c[3] = { i % n[0], i / n[0] % n[1], i / n[0] / n[1] };
        for (k = 0; k < 8; k++) {
            const size_t p[3] = { c[0] + k % 2, c[1] + k / 2 % 2, c[2] + k / 4 };
            at[k] = twice ? part_point(m, (double)p[0], (double)p[1], (double)p[2])
                  : p[0] + wide * (p[1] + deep * p[2]);
        }
        for (k = 0; k < 6; k++) {
            const size_t axis = 2 - k / 2;
            const int wall = k % 2 == 0 && c[axis] > 0, *q = corner[k];
            walls += (size_t)wall;
            if (!wall || twice) {
                part_triangle(m, at[q[0]], at[q[1]], at[q[2]]);
                part_triangle(m, at[q[0]], at[q[2]], at[q[3]]);
            }
        }
    }
    return walls;
}

/* A region's boundary is a manifold of that Euler number. */
static int is_closed(const pbw_tets *t, const pbw_solid_boundary *b, pbw_index region, long euler)
{
    pbw_index *facets = (pbw_index *)zoo_grow(NULL, (b->facet_count + 1) * 3 * sizeof *facets);
    pbwm3__topology top;
    pbwm3__work w;
    size_t i, count = 0;
    int right;
    for (i = 0; i < b->facet_count; i++) {
        if (b->sides[2 * i] == region || b->sides[2 * i + 1] == region) {
            memcpy(facets + 3 * count++, b->facets + 3 * i, 3 * sizeof *facets);
        }
    }
    memset(&w, 0, sizeof w);
    pbw_memory_start(&w.memory, NULL);
    right = pbwm3__examine(&w, facets, count, t->point_count, &top) && top.bad_edges + top.bad_points == 0
         && top.euler == euler;
    PBW_RELEASE(&w.memory, top.edges);
    PBW_RELEASE(&w.memory, top.flags);
    free(facets);
    return right;
}

typedef struct sheet { pbw_index v[3], region; } sheet;      /* a facet of a tetrahedron of that region */

static int compare_sheets(const void *a, const void *b)
{
    const sheet *x = (const sheet *)a, *y = (const sheet *)b;
    int k;
    for (k = 0; k < 2 && x->v[k] == y->v[k]; k++) {
    }
    return (x->v[k] > y->v[k]) - (x->v[k] < y->v[k]);
}

/* Returns how many facets have one tetrahedron, or two of different regions. */
static size_t count_sheets(const pbw_tets *t)
{
    sheet *s = (sheet *)zoo_grow(NULL, (4 * t->tet_count + 1) * sizeof *s);
    size_t i, k, count = 0;
    for (i = 0; i < 4 * t->tet_count; i++) {
        for (k = 0; k < 3; k++) {
            s[i].v[k] = t->corners[i / 4 * 4 + (i + k + 1) % 4];
        }
        pbwim__sort3(s[i].v);
        s[i].region = t->regions[i / 4];
    }
    qsort(s, 4 * t->tet_count, sizeof *s, compare_sheets);
    for (i = 0; i < 4 * t->tet_count; i = k) {
        for (k = i + 1; k < 4 * t->tet_count && compare_sheets(s + i, s + k) == 0; k++) {
        }
        count += k - i == 1 || (k - i == 2 && s[i].region != s[i + 1].region);
    }
    free(s);
    return count;
}

/* Two sheets of a boundary with the same four corners, whose facets meet at one diagonal below and at the other one
   above; once that below is turned, nothing lies between them. */
static void test_sheets(void)
{
    static const double points[6][3] = { { -0.7, 0, 0 }, { 0.7, 0, 0 }, { 0, -0.3, 0.02 }, { 0, 0.3, 0.02 },
                                         { 0.1, 0.05, -0.6 }, { 0, 0, 0.6 } };
    static const pbw_index corners[4][4] = { { 0, 1, 2, 4 }, { 0, 1, 3, 4 }, { 2, 3, 0, 5 }, { 2, 3, 1, 5 } };
    pbw_improve_options how;
    pbw_tets in, out;
    size_t i, boundary = 0;
    if (!test_begin("sheets that come to lie on each other")) {
        return;
    }
    memset(&in, 0, sizeof in);
    memset(&how, 0, sizeof how);
    in.points = points[0];
    in.point_count = 6;
    in.corners = corners[0];
    in.tet_count = 4;
    how.passes = 4;
    how.target = 60;
    how.feature_angle = 75;
    CHECK_EQUAL(pbw_improve(&in, &how, NULL, &out, NULL), PBW_OK);
    for (i = 0; i < 4 * out.tet_count; i++) {
        boundary += out.neighbors[i] == PBW_NONE;
    }
    CHECK(is_sound(&out) && out.tet_count == 4 && boundary == 8);
    CHECK_EQUAL(boundary, count_sheets(&out));
    pbw_tets_free(&out);
    test_end();
}

/* Cubes with walls in common: a region each, of its volume, its boundary a sphere. */
static void test_walls(void)
{
    static const size_t sizes[2][3] = { { 2, 1, 1 }, { 2, 2, 2 } };
    static part m;
    pbw_solid_options how;
    pbw_solid_boundary boundary;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    size_t i, regions, walls;
    double near;
    int k;
    if (!test_begin("walls")) {
        return;
    }
    for (k = 0; k < 8; k++) {                        /* two or eight; given once or twice; turned or not */
        const int twice = k / 2 % 2;
        walls = make_cubes(&m, sizes[k % 2], twice);
        regions = k % 2 ? 8 : 2;
        if (k / 4) {
            part_turn(&m);
        }
        in = input_of(&m);
        memset(&how, 0, sizeof how);
        how.size = 0.45;
        how.nested = k % 2;
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &boundary, &r), PBW_OK);
        CHECK(is_sound(&mesh));
        CHECK_EQUAL(r.bad_edges + r.bad_points + r.missing_edges + r.open_edges, 0);
        CHECK(r.regions == regions && r.shells == regions && r.settled && r.doubles == (twice ? 2 * walls : 0));
        CHECK(r.euler == 2 * (long)regions && r.input_euler == r.euler);
        CHECK_EQUAL(boundary.facet_count, count_sheets(&mesh));
        near = k == 5 || k == 7 ? 0.15 : 1e-9;       /* turned, facets may cut the corner where four walls meet */
        CHECK(fabs(r.input_volume - (double)regions) < 1e-12 && r.distance < near);
        CHECK(fabs(r.improve.after.volume - (double)regions) < 1e-9);
        for (i = 0; i < regions; i++) {
            const double volume = volume_of(&mesh, (pbw_index)i);
            CHECK(fabs(volume - 1) < near / 50);
            CHECK(is_boundary(&mesh, &boundary, (pbw_index)i, volume));
            CHECK(is_closed(&mesh, &boundary, (pbw_index)i, 2));
        }
        test_say("%zu tetrahedra, %.2f..%.2f", mesh.tet_count, r.improve.after.least, r.improve.after.largest);
        if (k == 5) {
            check_threads(&in, &how, &mesh);
        }
        pbw_solid_boundary_free(&boundary);
        pbw_tets_free(&mesh);
    }
    test_end();
}

/* A ball that a disk cuts in two, and a small ball in one half: three regions, or a cavity. */
static void test_cut_ball(void)
{
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    double line[13][2], small[5][2], volume, inner;
    size_t k;
    int nested;
    if (!test_begin("a ball cut by a disk")) {
        return;
    }
    for (k = 0; k <= 12; k++) {
        line[k][0] = k % 12 == 0 ? 0 : sin(PARTS_PI * (double)k / 12);
        line[k][1] = -cos(PARTS_PI * (double)k / 12);
    }
    for (k = 0; k < 5; k++) {
        small[k][0] = k % 4 == 0 ? 0 : 0.2 * sin(PARTS_PI * (double)k / 4);
        small[k][1] = 0.5 - 0.2 * cos(PARTS_PI * (double)k / 4);
    }
    m.points = m.triangles = 0;
    volume = part_turned(&m, 13, (const double (*)[2])line, 24, 0);
    for (k = 1; k < 23; k++) {                       /* points 121 to 144 are the equator */
        part_triangle(&m, 121, 121 + k, 122 + k);
    }
    inner = part_turned(&m, 5, (const double (*)[2])small, 12, 0);
    in = input_of(&m);
    memset(&how, 0, sizeof how);
    how.size = 0.25;
    for (nested = 0; nested < 2; nested++) {
        how.nested = nested;
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
        CHECK(is_sound(&mesh));
        CHECK_EQUAL(r.bad_edges + r.bad_points + r.missing_edges, 0);
        CHECK(r.shells == 3 && r.regions == (nested ? 3u : 2u) && r.crowded_edges == 24);
        CHECK(r.euler == (nested ? 8 : 6) && r.input_euler == r.euler && r.distance < 0.15);
        CHECK(fabs(r.input_volume - volume + (nested ? 0 : inner)) < 1e-9);
        CHECK(fabs(volume_of(&mesh, 0) - volume / 2) < 0.03 * volume);
        CHECK(fabs(volume_of(&mesh, 1) - volume / 2 + inner) < 0.03 * volume);
        CHECK(nested ? fabs(volume_of(&mesh, 2) - inner) < 0.2 * inner : 1);
        pbw_tets_free(&mesh);
    }
    test_end();
}

/* A torus around a circle of 0.5, thicker than that. */
static void add_spindle(part *m)
{
    size_t i;
    for (i = 0; i < 24 * 16; i++) {
        const double u = PARTS_PI * (double)(i / 16) / 12, v = PARTS_PI * ((double)(i % 16) + 0.5) / 8;
        const double radius = 0.5 + 0.8 * cos(v);
        const size_t next = (i / 16 + 1) % 24 * 16, up = (i + 1) % 16;
        (void)part_point(m, radius * cos(u), radius * sin(u), 0.8 * sin(v));
        part_triangle(m, i, next + i % 16, next + up);
        part_triangle(m, i, next + up, i / 16 * 16 + up);
    }
}

/* Shells that cross are one body, their union; a surface that crosses itself is filled where its winding number is
   above 0: in the core of a spindle torus it is 0.  The facets are the boundary. */
static void test_unions(void)
{
    static const double low[2][3] = { { 0, 0, 0 }, { 0.6, 0.5, 0.4 } };
    static const double high[2][3] = { { 1, 1, 1 }, { 1.6, 1.3, 1.2 } };
    static part m;
    pbw_solid_options how;
    pbw_solid_boundary b;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    size_t i, k;
    int kind;
    if (!test_begin("unions")) {
        return;
    }
    memset(&how, 0, sizeof how);
    for (kind = 0; kind < 4; kind++) {               /* two boxes, one of them turned inside out; a spindle torus;
                                                        two balls */
        double volume = 1 + 0.64 - 0.4 * 0.5 * 0.6;
        m.points = m.triangles = 0;
        for (i = 0; i < 2 && kind < 2; i++) {
            (void)part_box(&m, low[i], high[i], kind == 1 && i == 1);
        }
        if (kind == 2) {
            add_spindle(&m);
        }
        for (k = 0; k < 8 && kind == 2; k++) {       /* what the upper half of the outline sweeps, twice */
            const double v[2] = { PARTS_PI * ((double)k - 0.5) / 8, PARTS_PI * ((double)k + 0.5) / 8 };
            const double p = fmax(0.5 + 0.8 * cos(v[0]), 0), q = fmax(0.5 + 0.8 * cos(v[1]), 0);
            const double height = k == 0 ? 0.8 * sin(v[1]) : 0.8 * (sin(v[1]) - sin(v[0]));
            volume = (k == 0 ? 0 : volume) + 2 * 3.106 * height * (p * p + p * q + q * q) / 3;
        }
        for (i = 0; i < 2 && kind == 3; i++) {
            double line[13][2];
            for (k = 0; k < 13; k++) {
                line[k][0] = k % 12 == 0 ? 0 : sin(PARTS_PI * (double)k / 12);
                line[k][1] = -cos(PARTS_PI * (double)k / 12);
            }
            volume = 1.75 * part_turned(&m, 13, (const double (*)[2])line, 24, 0);       /* about */
            for (k = m.points / 2; k < m.points && i == 1; k++) {
                m.x[k][0] += 1.13;
                m.x[k][1] += 0.11;
            }
        }
        in = input_of(&m);
        how.size = kind == 2 ? 0.3 : 0.25;
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &b, &r), PBW_OK);
        CHECK(is_sound(&mesh) && r.crossings > 0 && r.united && r.bad_edges + r.bad_points == 0);
        CHECK_EQUAL(r.euler, kind == 2 ? 4 : 2);
        CHECK(kind < 3 || (r.sharp_edges > 20 && r.missing_edges == 0 && r.distance < 0.12));
        CHECK_EQUAL(b.facet_count, count_sheets(&mesh));
        CHECK(kind >= 2 ? r.improve.after.volume > 0.9 * volume : fabs(r.improve.after.volume - volume) < 1e-6);
        CHECK(kind >= 2 || (r.sharp_edges >= 30 && r.missing_edges == 0 && r.distance < 1e-6));
        CHECK(r.input_volume > r.improve.after.volume - 1e-6 && r.input_volume < 1.03 * r.improve.after.volume);
        test_say("%zu tetrahedra, %.2f..%.2f, volume %.4f of %.4f, %zu crossings, Euler %ld, %zu + %zu faults",
                 mesh.tet_count, r.improve.after.least, r.improve.after.largest, r.improve.after.volume, volume,
                 r.crossings, r.euler, r.bad_edges, r.bad_points);
        if (kind == 1) {
            check_threads(&in, &how, &mesh);
        }
        pbw_solid_boundary_free(&b);
        pbw_tets_free(&mesh);
    }
    test_end();
}

/* A prism over a regular polygon of n corners and radius 1, from `low` to `high` along an axis.  Returns its
   volume. */
static double add_prism(part *m, size_t n, int axis, double turn, double low, double high)
{
    const size_t first = m->points;
    size_t i, k;
    for (i = 0; i < 2 * n + 2; i++) {
        const double angle = 2 * PARTS_PI * ((double)(i % n) + turn) / (double)n;
        double p[3];
        p[axis] = i < n || i == 2 * n ? low : high;
        p[(axis + 1) % 3] = i < 2 * n ? cos(angle) : 0;
        p[(axis + 2) % 3] = i < 2 * n ? sin(angle) : 0;
        (void)part_point(m, p[0], p[1], p[2]);
    }
    for (i = first; i < first + n; i++) {
        k = i + 1 < first + n ? i + 1 : first;
        part_triangle(m, i, k, k + n);
        part_triangle(m, i, k + n, i + n);
        part_triangle(m, first + 2 * n, k, i);
        part_triangle(m, first + 2 * n + 1, i + n, k + n);
    }
    return 0.5 * (double)n * sin(2 * PARTS_PI / (double)n) * (high - low);
}

/* The volume that two of these prisms have in common, along different axes, turned so that a corner or the middle of
   a side is on the third axis: layers of it are squares. */
static double in_common(size_t n, double turn)
{
    const double top = turn > 0 ? cos(PARTS_PI / (double)n) : 1;
    double sum = 0, from = -top;
    size_t i;
    for (i = 0; i < n; i++) {                        /* from corner to corner, in the order of their heights */
        double next = top, width[3];
        size_t k, at;
        for (k = 0; k < n; k++) {
            const double height = sin(2 * PARTS_PI * ((double)k + turn) / (double)n);
            next = height > from + 1e-9 && height < next ? height : next;
        }
        if (next <= from) {
            break;
        }
        for (at = 0; at < 3; at++) {
            const double z = from + (next - from) * (double)at / 2;
            width[at] = 2;
            for (k = 0; k < n; k++) {                /* as the sides let it */
                const double angle = 2 * PARTS_PI * ((double)k + turn + 0.5) / (double)n;
                const double reach = cos(PARTS_PI / (double)n);
                width[at] = cos(angle) > 1e-9 ? fmin(width[at], 2 * fmax(0, (reach - sin(angle) * z) / cos(angle)))
                          : width[at];
            }
        }
        sum += (next - from) / 6 * (width[0] * width[0] + 4 * width[1] * width[1] + width[2] * width[2]);
        from = next;
    }
    return sum;
}

/* What users join: prisms that cross at a right angle, edge on edge or side on side, boxes that overlap with faces in
   one plane, boxes that touch with a part of a face, a T of prisms, and three boxes: bodies with the right volume and
   sharp edges. */
static void test_joints(void)
{
    static const double box[6][2][3] = { { { 0, 0, 0 }, { 2, 2, 1 } }, { { 1, 1, 0 }, { 3, 3, 1 } },
                                         { { 2, 1, 0 }, { 3, 3, 1 } }, { { -1, -1, 0.5 }, { 0.5, 0.5, 2 } },
                                         { { 0.25, -1, 0.25 }, { 2, 0.5, 1.75 } }, { { 0, 0, 0 }, { 2, 2, 1 } } };
    static const double volumes[4] = { 7, 6, 4 + 3.375 + 3.9375 - 0.125 - 0.65625 - 0.46875 + 0.0625, 4 };
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    int kind;
    if (!test_begin("joints")) {
        return;
    }
    memset(&how, 0, sizeof how);
    for (kind = 0; kind < 7; kind++) {
        double volume = kind < 4 ? volumes[kind] : 0;
        m.points = m.triangles = 0;
        if (kind < 4) {
            (void)part_box(&m, box[0][0], box[0][1], 0);
            (void)part_box(&m, box[kind == 2 ? 3 : kind == 3 ? 5 : kind + 1][0],
                           box[kind == 2 ? 3 : kind == 3 ? 5 : kind + 1][1], 0);
        }
        if (kind == 2) {
            (void)part_box(&m, box[4][0], box[4][1], 0);
        }
        if (kind >= 4) {
            const double turn = kind == 5 ? 0.5 : 0;
            volume = add_prism(&m, 24, 0, turn, -2.5, 2.5) + add_prism(&m, 24, 1, turn, kind == 6 ? 0 : -2.5, 2.5)
                   - in_common(24, turn) * (kind == 6 ? 0.5 : 1);
        }
        in = input_of(&m);
        how.size = kind < 4 ? 0.3 : 0.4;
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
        CHECK(is_sound(&mesh) && r.bad_edges + r.bad_points + r.missing_edges == 0 && r.settled);
        CHECK(kind == 3 ? r.doubles > 0 : r.crossings > 0 && r.united);
        CHECK(r.euler == 2 && r.input_euler == 2);
        CHECK(fabs(r.input_volume - volume) < 1e-6 * volume);
        CHECK(fabs(r.improve.after.volume - volume) < (kind < 4 ? 1e-6 : 0.03) * volume);
        CHECK(r.improve.after.least > 25 && r.distance < 0.15);
        test_say("joint %d: %zu tetrahedra, %.2f..%.2f, volume %.6f of %.6f, distance %.3f, Euler %ld, %zu missing",
                 kind, mesh.tet_count, r.improve.after.least, r.improve.after.largest, r.improve.after.volume,
                 volume, r.distance, r.euler, r.missing_edges);
        pbw_tets_free(&mesh);
    }
    test_end();
}

/* A ball with points that are moved at random: its edges bend, but are not sharp at the scale of the size.  An L with
   such a ball keeps its own sharp edges alone. */
/* Edges between planes that go on for three sizes are sharp, although those of an icosahedron bend by 41.8 degrees
   only; so are they if one of its facets is cut. */
static void test_planes(void)
{
    static const double golden = 1.6180339887498949;
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    size_t i, k;
    if (!test_begin("sharp edges between planes")) {
        return;
    }
    m.points = m.triangles = 0;
    for (i = 0; i < 12; i++) {
        double p[3];
        p[i / 4] = 0;
        p[(i / 4 + 1) % 3] = i % 2 ? 1 : -1;
        p[(i / 4 + 2) % 3] = i / 2 % 2 ? golden : -golden;
        (void)part_point(&m, p[0], p[1], p[2]);
    }
    for (i = 0; i < 12 * 12 * 12; i++) {             /* corners that are 2 apart */
        const size_t at[3] = { i / 144, i / 12 % 12, i % 12 };
        double far = at[0] < at[1] && at[1] < at[2] ? 0 : 1;
        for (k = 0; k < 3; k++) {
            const double *p = m.x[at[k]], *q = m.x[at[(k + 1) % 3]];
            far = fmax(far, fabs(sqrt(pow(p[0] - q[0], 2) + pow(p[1] - q[1], 2) + pow(p[2] - q[2], 2)) - 2));
        }
        if (far < 1e-9) {
            part_triangle(&m, at[0], at[1], at[2]);
        }
    }
    memset(&how, 0, sizeof how);
    how.improve.seconds = 1e-9;                      /* the report holds nevertheless */
    how.size = 2.0 / 8;
    for (k = 0; k < 2; k++) {
        in = input_of(&m);
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_CANCELLED);
        CHECK_EQUAL(m.triangles, 20 + 2 * k);
        CHECK(r.open_edges == 0 && r.sharp == PBW_SOLID_SHARP_ALL && r.sharp_edges == 30);
        CHECK(r.sharp_share >= 1);
        (void)part_point(&m, (m.x[m.t[0][0]][0] + m.x[m.t[0][1]][0] + m.x[m.t[0][2]][0]) / 3,
                         (m.x[m.t[0][0]][1] + m.x[m.t[0][1]][1] + m.x[m.t[0][2]][1]) / 3,
                         (m.x[m.t[0][0]][2] + m.x[m.t[0][1]][2] + m.x[m.t[0][2]][2]) / 3);
        part_triangle(&m, m.t[0][1], m.t[0][2], 12);
        part_triangle(&m, m.t[0][2], m.t[0][0], 12);
        m.t[0][2] = 12;
    }
    test_end();
}

static void test_sharp(void)
{
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    size_t i, ball;
    int kind;
    if (!test_begin("sharp edges at the scale of the size")) {
        return;
    }
    for (kind = 0; kind < 3; kind++) {
        memset(&how, 0, sizeof how);
        m.points = m.triangles = 0;
        if (kind > 0) {
            (void)part_make(PART_L, 0, &m);
        }
        ball = m.points;
        if (kind < 2) {
            static part whole;
            (void)part_make(PART_BALL, 0, &whole);
            for (i = 0; i < whole.triangles / 2; i++) {          /* the outer shell */
                part_triangle(&m, ball + whole.t[i][0], ball + whole.t[i][1], ball + whole.t[i][2]);
            }
            for (i = 0; i < whole.points / 2; i++) {
                const double s = 1 + 0.05 * sin(77 * (double)i * (double)i);
                (void)part_point(&m, s * whole.x[i][0] + 4, s * whole.x[i][1], s * whole.x[i][2]);
            }
        }
        in = input_of(&m);
        how.size = 0.35;
        how.improve.passes = 1;
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
        CHECK(kind == 0 ? r.sharp == PBW_SOLID_SHARP_NONE && r.sharp_edges == 0
              : kind == 1 ? r.sharp_share < 0.85 : r.sharp == PBW_SOLID_SHARP_ALL && r.sharp_edges == 18);
        test_say("share %.3f, %zu kept", r.sharp_share, r.sharp_edges);
        pbw_tets_free(&mesh);
        how.sharp = kind == 1 ? PBW_SOLID_SHARP_SOME : kind == 0 ? PBW_SOLID_SHARP_ALL : PBW_SOLID_SHARP_NONE;
        how.rounds = 2;
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
        CHECK(kind == 0 ? r.sharp_edges > 50 : r.sharp_edges == (kind == 1 ? 18u : 0u));
        pbw_tets_free(&mesh);
    }
    test_end();
}

static void note_plan(void *user, const pbw_solid_report *r)
{
    *(double *)user = r->estimate;
}

/* Refused before work: what is mostly open, what is thin, what needs too many tetrahedra, what has no time; and what
   was refused is filled if asked for.  A plate of a tenth of the size is not refused. */
static void test_refusals(void)
{
    static const double low[3] = { 0, 0, 0 }, plate[3] = { 6, 6, 0.15 }, cube[3] = { 1, 1, 1 };
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    double plan = 0;
    if (!test_begin("refusals")) {
        return;
    }
    memset(&how, 0, sizeof how);
    m.points = m.triangles = 0;
    (void)part_box(&m, low, cube, 0);
    m.triangles = 6;                                 /* half of a cube */
    in = input_of(&m);
    how.size = 0.2;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_DEGENERATE);
    CHECK(r.refusal == PBW_SOLID_OPEN && r.holes == 1 && r.hole_share > 0.5 && mesh.points == NULL);
    how.close = 1;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
    CHECK(r.refusal == PBW_SOLID_FILLED && r.hole[0].closed && is_sound(&mesh) && r.bad_edges + r.bad_points == 0);
    pbw_tets_free(&mesh);
    memset(&how, 0, sizeof how);
    m.points = m.triangles = 0;
    (void)part_box(&m, low, plate, 0);
    in = input_of(&m);
    how.size = 3;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_DEGENERATE);
    CHECK(r.refusal == PBW_SOLID_THIN && fabs(r.thickness - 10.8 / 75.6 / 3) < 1e-12);
    how.size = 1.5;
    how.plan = note_plan;
    how.plan_user = &plan;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
    CHECK(r.improve.after.least > 28 && fabs(r.improve.after.volume - 5.4) < 1e-9);
    CHECK(plan > 0.5 * (double)mesh.tet_count && plan < 2 * (double)mesh.tet_count);
    test_say("about %.0f, %zu tetrahedra", plan, mesh.tet_count);
    pbw_tets_free(&mesh);
    how.most = plan / 2;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_ERROR_TOO_LARGE);
    CHECK(r.refusal == PBW_SOLID_LARGE && fabs(r.estimate - plan) < 1e-6);
    how.most = 0;
    how.improve.seconds = 1e-9;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_CANCELLED);
    CHECK(r.refusal == PBW_SOLID_LATE && mesh.points == NULL);
    test_end();
}

/* The caller's patches are on facets and bound them; without, planes are the patches of a cube. */
static void test_patches(void)
{
    static const double low[3] = { 0, 0, 0 }, high[3] = { 1, 1, 1 };
    static part m;
    pbw_index number[12];
    pbw_solid_options how;
    pbw_solid_boundary b;
    pbw_solid_input in;
    pbw_tets mesh;
    double area[2] = { 0, 0 }, length = 0;
    size_t i;
    int given;
    if (!test_begin("patches")) {
        return;
    }
    make_box(&m, low, high);
    part_turn(&m);
    memset(&how, 0, sizeof how);
    how.size = 0.3;
    for (given = 0; given < 2; given++) {
        in = input_of(&m);
        for (i = 0; i < 12; i++) {
            number[i] = i == 2 ? 9 : 4;              /* half of a side */
        }
        in.patches = given ? number : NULL;
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &b, NULL), PBW_OK);
        area[0] = area[1] = length = 0;
        for (i = 0; i < b.facet_count; i++) {
            double n[3];
            pbwsf__normal(mesh.points + 3 * (size_t)b.facets[3 * i], mesh.points + 3 * (size_t)b.facets[3 * i + 1],
                          mesh.points + 3 * (size_t)b.facets[3 * i + 2], n);
            CHECK(given ? b.patches[i] == 4 || b.patches[i] == 9 : b.patches[i] < 6);
            area[b.patches[i] == (given ? 9u : 3u)] += 0.5 * sqrt(pbwsf__dot(n, n));
        }
        for (i = 0; i < b.edge_count; i++) {
            length += pbwsf__distance(mesh.points + 3 * (size_t)b.edges[2 * i],
                                      mesh.points + 3 * (size_t)b.edges[2 * i + 1]);
        }
        CHECK(fabs(area[1] - (given ? 0.5 : 1)) < 1e-9 && fabs(area[0] + area[1] - 6) < 1e-9);
        CHECK(fabs(length - (given ? 12 + sqrt(2.0) : 12)) < 1e-9);
        pbw_solid_boundary_free(&b);
        pbw_tets_free(&mesh);
    }
    test_end();
}

static double size_at(void *user, const double p[3])
{
    return p[0] < 0.3 ? *(const double *)user : HUGE_VAL;
}

/* Edges follow the caller's sizes and the curvature. */
static void test_sizes(void)
{
    pbw_solid_options how;
    pbw_solid_input in = input_by(sphere);
    pbw_solid_report r;
    pbw_tets mesh;
    pbw_options one;
    double fine = 0.1, mean[2] = { 0, 0 };
    size_t count[2] = { 0, 0 }, tets, i;
    if (!test_begin("sizes")) {
        return;
    }
    memset(&how, 0, sizeof how);
    memset(&one, 0, sizeof one);
    how.size = 0.4;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
    tets = mesh.tet_count;
    pbw_tets_free(&mesh);
    how.curvature = 0.2 * sqrt(2.0);                 /* of a sphere: edges of 0.2 */
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
    CHECK(mesh.tet_count > 5 * tets && mesh.tet_count < 12 * tets && r.settled);
    test_say("%zu tetrahedra, by curvature %zu", tets, mesh.tet_count);
    pbw_tets_free(&mesh);
    how.curvature = 0;
    how.size_at = size_at;
    how.size_user = &fine;
    one.threads = 1;
    CHECK_EQUAL(pbw_solid(&in, &how, &one, &mesh, NULL, &r), PBW_OK);
    check_threads(&in, &how, &mesh);
    CHECK(is_sound(&mesh) && r.settled && r.euler == 2 && r.bad_edges + r.bad_points == 0);
    CHECK(r.improve.after.least > 20);
    for (i = 0; i < 6 * mesh.tet_count; i++) {
        const double *a = mesh.points + 3 * (size_t)mesh.corners[i / 6 * 4 + (size_t)pbwim__edge[i % 6][0]];
        const double *b = mesh.points + 3 * (size_t)mesh.corners[i / 6 * 4 + (size_t)pbwim__edge[i % 6][1]];
        if (a[0] < 0 || a[0] > 0.95) {
            count[a[0] > 0]++;
            mean[a[0] > 0] += pbwsf__distance(a, b);
        }
    }
    mean[0] /= (double)count[0];
    mean[1] /= (double)count[1];
    CHECK(mean[0] > 0.06 && mean[0] < 0.13 && mean[1] > 0.2);
    test_say("%zu tetrahedra %.2f..%.2f, edges %.4f and %.4f", mesh.tet_count, r.improve.after.least,
             r.improve.after.largest, mean[0], mean[1]);
    tets = mesh.tet_count;
    pbw_tets_free(&mesh);
    how.gradation = 0.05;                            /* sizes grow slowly from where they are small */
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
    CHECK(mesh.tet_count > tets + tets / 10 && r.settled);
    test_say("%zu tetrahedra with a gradation of 0.05", mesh.tet_count);
    pbw_tets_free(&mesh);
    how.gradation = -1;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_ERROR_ARGUMENT);
    test_end();
}

/* Sizes of regions: a box in a box, and two cubes with a wall in common. */
static void test_region_sizes(void)
{
    static const double at[3] = { 0, 0, 0 }, end[3] = { 2, 2, 2 }, low[3] = { 0.7, 0.7, 0.7 };
    static const double high[3] = { 1.3, 1.3, 1.3 };
    static const size_t two[3] = { 2, 1, 1 };
    static part m;
    const double sizes[2] = { 0, 0.1 }, wrong[2] = { 0.1, -1 };
    pbw_solid_options how;
    pbw_options one;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    size_t i;
    int walls;
    if (!test_begin("sizes of regions")) {
        return;
    }
    for (walls = 0; walls < 2; walls++) {
        double mean[2] = { 0, 0 }, most = 0;
        size_t count[2] = { 0, 0 };
        m.points = m.triangles = 0;
        if (walls) {
            (void)make_cubes(&m, two, 0);
        } else {
            (void)part_box(&m, at, end, 0);
            (void)part_box(&m, low, high, 0);
        }
        in = input_of(&m);
        memset(&how, 0, sizeof how);
        memset(&one, 0, sizeof one);
        how.size = 0.4;
        how.nested = 1;
        how.region_sizes = sizes;
        how.region_size_count = 2;
        one.threads = 1;
        CHECK_EQUAL(pbw_solid(&in, &how, &one, &mesh, NULL, &r), PBW_OK);
        check_threads(&in, &how, &mesh);
        CHECK(is_sound(&mesh) && r.settled && r.regions == 2 && r.bad_edges + r.bad_points == 0);
        CHECK(r.improve.after.least > 20);
        for (i = 0; i < 6 * mesh.tet_count; i++) {
            const double length = pbwsf__distance(
                mesh.points + 3 * (size_t)mesh.corners[i / 6 * 4 + (size_t)pbwim__edge[i % 6][0]],
                mesh.points + 3 * (size_t)mesh.corners[i / 6 * 4 + (size_t)pbwim__edge[i % 6][1]]);
            const size_t region = mesh.regions[i / 6];
            count[region]++;
            mean[region] += length;
            most = region == 1 ? fmax(most, length) : most;
        }
        mean[0] /= (double)count[0];
        mean[1] /= (double)count[1];
        CHECK(mean[1] > 0.05 && mean[1] < 0.12 && most < 0.25 && mean[0] > 1.3 * mean[1]);
        test_say("%zu tetrahedra, edges %.4f and %.4f, at most %.4f", mesh.tet_count, mean[0], mean[1], most);
        pbw_tets_free(&mesh);
    }
    how.region_sizes = wrong;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_ERROR_ARGUMENT);
    test_end();
}

/* A ball without some triangles: holes named and closed; a half of it; its triangles turned any way. */
static void test_holes(void)
{
    static part m;
    pbw_solid_options how;
    pbw_solid_boundary b;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_tets mesh;
    size_t i, count = 0, closing = 0;
    double volume;
    if (!test_begin("holes")) {
        return;
    }
    volume = part_make(PART_BALL, 1, &m);
    m.triangles /= 2;                                /* the outer shell */
    volume /= 1 - 0.216;
    for (i = 0; i < m.triangles; i++) {
        if (i < 32 || i / 3 == 100) {                /* a cap, and three triangles together */
            continue;
        }
        memmove(m.t[count], m.t[i], sizeof m.t[0]);
        if (i % 3 == 0) {
            const pbw_index was = m.t[count][0];
            m.t[count][0] = m.t[count][1];
            m.t[count][1] = was;
        }
        count++;
    }
    m.triangles = count;
    in = input_of(&m);
    memset(&how, 0, sizeof how);
    how.size = 0.2;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, &b, &r), PBW_OK);
    CHECK(is_sound(&mesh));
    CHECK(r.settled && r.euler == 2 && r.bad_edges + r.bad_points == 0);
    CHECK(r.open_edges == 37 && r.holes == 2 && b.hole_count == 2);
    CHECK(r.hole[0].edges == 32 && r.hole[0].closed && r.hole[1].edges == 5 && r.hole[1].closed);
    CHECK(fabs(r.hole[0].length - 32 * 2 * sin(PARTS_PI / 16) * sin(PARTS_PI / 32)) < 1e-9);
    CHECK(fabs(pbwsf__dot(r.hole[0].place, r.hole[0].place) - pow(cos(PARTS_PI / 16), 2)) < 1e-9);
    CHECK(r.improve.after.least > 20 && fabs(r.improve.after.volume - volume) < 0.02 * volume);
    for (i = 0; i < b.facet_count; i++) {
        closing += b.patches[i] == PBW_NONE;
    }
    CHECK(closing > 0 && closing < b.facet_count / 10);
    test_say("%zu tetrahedra %.2f..%.2f, %zu of %zu facets close holes", mesh.tet_count, r.improve.after.least,
             r.improve.after.largest, closing, b.facet_count);
    pbw_solid_boundary_free(&b);
    pbw_tets_free(&mesh);
    test_end();
}

/* Open, crowded, empty and random input: counted, or refused, and it ends. */
static void test_warnings(void)
{
    static part m;
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
    (void)part_make(PART_L, 0, &m);
    m.triangles -= 1;
    in = input_of(&m);
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
    CHECK_EQUAL(r.open_edges, 3);
    CHECK(is_sound(&mesh));
    pbw_tets_free(&mesh);
    m.triangles = 1;
    in = input_of(&m);
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_DEGENERATE);
    in.triangle_count = 0;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_DEGENERATE);
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
        status = pbw_solid(&in, &how, NULL, &mesh, NULL, &r);
        CHECK(status == PBW_OK || status == PBW_DEGENERATE);
        CHECK(status != PBW_OK || (is_sound(&mesh) && r.open_edges + r.crowded_edges > 0));
        pbw_tets_free(&mesh);
    }
    m.t[3][1] = 77777;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_ERROR_ARGUMENT);
    m.t[3][1] = 0;
    m.x[3][1] = HUGE_VAL;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_ERROR_NOT_FINITE);
    m.x[3][1] = 0;
    how.size = 1e-9;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_ERROR_TOO_LARGE);
    test_end();
}

/* Refuses one request for memory, alone or with all after it, then the next one, until none is refused: the call fails
   or makes the same mesh. */
static void check_allocations(const pbw_solid_input *in, const pbw_solid_options *how, pbw_options *options,
                              meter *memory)
{
    pbw_solid_boundary boundary;
    pbw_tets mesh, other;
    pbw_status status = PBW_OK;
    long k;
    int all, refused;
    CHECK_EQUAL(pbw_solid(in, how, NULL, &mesh, NULL, NULL), PBW_OK);
    for (all = 0; all < 2; all++) {
        for (k = refused = 1; refused && k < 5000; k++) {
            meter_start(memory, k, all);
            status = pbw_solid(in, how, options, &other, &boundary, NULL);
            refused = memory->refused > 0;
            CHECK(status == PBW_ERROR_MEMORY ? refused : is_same(&mesh, &other) && boundary.facet_count > 0);
            pbw_solid_boundary_free(&boundary);
            pbw_tets_free(&other);
            CHECK(memory->blocks == 0 && memory->faults == 0);
        }
        CHECK(k > 50 && status == PBW_OK);
    }
    pbw_tets_free(&mesh);
}

/* Cancels at one question, then at the next one, until there are no more: nothing is left. */
static void check_cancelling(const pbw_solid_input *in, const pbw_solid_options *how, pbw_options *options,
                             meter *memory)
{
    pbw_status status = PBW_CANCELLED;
    pbw_tets mesh;
    watch w;
    long k;
    meter_start(memory, 0, 0);
    options->progress = watch_progress;
    options->progress_user = &w;
    for (k = 1; status == PBW_CANCELLED && k < 5000; k++) {
        watch_start(&w, k);
        status = pbw_solid(in, how, options, &mesh, NULL, NULL);
        CHECK(w.wrong == 0);
        CHECK(status == PBW_OK || mesh.points == NULL);
        pbw_tets_free(&mesh);
        CHECK(memory->blocks == 0);
    }
    CHECK(k > 50 && status == PBW_OK);
    options->progress = NULL;
}

static void test_failures(void)
{
    static const double corner[4][3] = { { 0, 0, 0 }, { 1, 1, 1 }, { 2, 2, 2 }, { 3, 3, 3 } };
    static part m, two, horn;
    pbw_options options;
    pbw_solid_options how;
    pbw_solid_input in;
    pbw_solid_report r;
    pbw_tets mesh;
    meter memory;
    double line[13][2];
    size_t k;
    if (!test_begin("failing allocations, cancelling")) {
        return;
    }
    (void)part_make(PART_L, 0, &m);
    m.triangles--;                                   /* a hole to close */
    in = input_of(&m);
    memset(&options, 0, sizeof options);
    memset(&how, 0, sizeof how);
    how.size = 1.2;
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &memory;
    check_allocations(&in, &how, &options, &memory);
    check_cancelling(&in, &how, &options, &memory);
    how.improve.target = -1;
    (void)part_box(&two, corner[0], corner[2], 0);   /* boxes that cross */
    (void)part_box(&two, corner[1], corner[3], 0);
    in = input_of(&two);
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
    CHECK(r.united);
    pbw_tets_free(&mesh);
    check_allocations(&in, &how, &options, &memory);
    check_cancelling(&in, &how, &options, &memory);
    for (k = 0; k < 13; k++) {                       /* a ball with a horn, of which the tip is reached after rounds */
        line[k][0] = k % 12 == 0 ? 0 : sin(PARTS_PI * (double)k / 12);
        line[k][1] = k == 12 ? 3 : -cos(PARTS_PI * (double)k / 12);
    }
    (void)part_turned(&horn, 13, (const double (*)[2])line, 12, 0);
    in = input_of(&horn);
    how.size = 1.2;
    how.rounds = 2;
    how.sharp = PBW_SOLID_SHARP_NONE;
    CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
    CHECK(r.distance < 1.2);                         /* 1.66 where it is not reached */
    pbw_tets_free(&mesh);
    check_allocations(&in, &how, &options, &memory);
    check_cancelling(&in, &how, &options, &memory);
    test_end();
}

/* Cuts one triangle by segments in its plane.  Returns how many places there are where two of them cross, -1 without
   memory; they are those that comparing all segments finds, in that order, if `all` is not 0. */
static long count_places(double (*ends)[3], size_t segments, int all)
{
    static const double corner[3][3] = { { -9, -9, -9 }, { 9, -9, 0 }, { 0, 9, 4 } };
    static const pbw_index triangle[3] = { 0, 1, 2 };
    pbwm3__work w;
    pbwm3__cutting c;
    size_t i, k, at;
    long count = -1;
    memset(&w, 0, sizeof w);
    memset(&c, 0, sizeof c);
    pbw_memory_start(&w.memory, NULL);
    w.surface.points = corner[0];
    w.surface.triangles = triangle;
    if (PBW_ZEROS(&w.memory, c.first, 2) && PBW_FIT(&w.memory, c.pairs, segments)
        && PBW_ZEROS(&w.memory, c.layer, segments) && PBW_FIT(&w.memory, c.places, 2 * segments)) {
        for (i = 0; i < segments; i++) {
            c.pairs.at[i] = i;
        }
        c.first.at[1] = segments;
        memcpy(c.places.at, ends, 2 * segments * sizeof *ends);
        c.places.count = 2 * segments;
        count = pbwm3__find_places(&w, &c, 0) ? (long)c.extra.count : -1;
    }
    for (i = at = 0; all && i < c.spans.count; i++) {
        for (k = i + 1; k < c.spans.count; k++) {
            if (pbwm3__spans_cross(c.spans.at + i, c.spans.at + k)) {
                double p[3];
                CHECK(at < c.extra.count && c.extra.at[at][0] == 0 && c.extra.at[at][1] == 2 * segments + at);
                memcpy(p, c.places.at[2 * segments + at++], sizeof p);
                CHECK(fabs(pbwsf__distance(p, c.places.at[2 * c.spans.at[i].pair])
                           + pbwsf__distance(p, c.places.at[2 * c.spans.at[i].pair + 1])
                           - pbwsf__distance(c.places.at[2 * c.spans.at[i].pair],
                                             c.places.at[2 * c.spans.at[i].pair + 1])) < 1e-9);
            }
        }
    }
    CHECK(!all || (long)at == count);
    pbwm3__free_cutting(&w, &c);
    CHECK(w.memory.used == 0);
    return count;
}

/* Segments in one triangle: where they cross, and that many that lie beside each other take no time for each pair: of
   40,000, comparing all takes six seconds. */
static void test_places(void)
{
    enum { MOST = 40000 };
    static double ends[2 * MOST][3];
    const size_t most = MOST;
    double seconds;
    size_t i, k;
    int turn;
    if (!test_begin("places where segments cross")) {
        return;
    }
    for (turn = 0; turn < 40; turn++) {              /* at random; in each second turn, of lattice points */
        for (i = 0; i < 60; i++) {
            double x[2];
            for (k = 0; k < 2; k++) {
                x[k] = turn % 2 ? floor(9 * (double)(pbw_random((uint64_t)turn, 2 * i + k) >> 11) / 9007199254740992.0)
                     : 4 * (double)(pbw_random((uint64_t)turn, 2 * i + k) >> 11) / 9007199254740992.0;
            }
            ends[i][0] = x[0];                       /* in the triangle's plane */
            ends[i][1] = x[1];
            ends[i][2] = -4.5 + 0.5 * x[0] + 8.5 / 18 * x[1];
        }
        CHECK(count_places(ends, 30, 1) > 5);
    }
    for (turn = 0; turn < 3; turn++) {               /* parallel ones, which one crosses */
        const double along[2] = { turn == 1 ? 0 : 1, turn == 0 ? 0 : 0.625 };
        for (i = 0; i < 2 * most; i++) {
            const double side = (double)(i / 2) / (double)most - 0.5, end = i % 2 ? 4 : -4;
            ends[i][0] = end * along[0] - side * along[1];
            ends[i][1] = end * along[1] + side * along[0];
            if (i / 2 == most - 1) {
                ends[i][0] = -along[1] * end;
                ends[i][1] = along[0] * end;
            }
            ends[i][2] = -4.5 + 0.5 * ends[i][0] + 8.5 / 18 * ends[i][1];
        }
        seconds = (double)clock() / CLOCKS_PER_SEC;
        CHECK_EQUAL(count_places(ends, most, 0), (long)most - 1);
        seconds = (double)clock() / CLOCKS_PER_SEC - seconds;
        test_say("%.3f s", seconds);
        CHECK(seconds < 1);
    }
    test_end();
}

/* Two balls that touch in a point. */
static void add_balls(part *m)
{
    double line[13][2];
    size_t k;
    for (k = 0; k < 13; k++) {
        line[k][0] = k % 12 == 0 ? 0 : sin(PARTS_PI * (double)k / 12);
        line[k][1] = -cos(PARTS_PI * (double)k / 12);
    }
    (void)part_turned(m, 13, (const double (*)[2])line, 24, 0);
    for (k = 0; k < 13; k++) {
        line[k][1] += 2;
    }
    (void)part_turned(m, 13, (const double (*)[2])line, 24, 0);
}

/* Where parts of the boundary touch, they are joined or separated: at the tips inside of a spindle torus, where two
   balls touch.  Two boxes that touch in a corner stay as they are. */
static void test_touching(void)
{
    static const double sizes[5] = { 0.27, 0.33, 0.6, 0.6, 1 };
    static const double corner[3][3] = { { 0, 0, 0 }, { 1, 1, 1 }, { 2, 2, 2 } };
    static part m;
    pbw_solid_options how;
    pbw_solid_report r;
    pbw_solid_input in;
    pbw_options options;
    pbw_tets mesh;
    meter memory;
    int i;
    if (!test_begin("parts that touch")) {
        return;
    }
    memset(&how, 0, sizeof how);
    how.improve.target = -1;
    for (i = 0; i < 5; i++) {
        m.points = m.triangles = 0;
        if (i < 3) {
            add_spindle(&m);
        } else if (i == 3) {
            (void)part_box(&m, corner[0], corner[1], 0);
            (void)part_box(&m, corner[1], corner[2], 0);
        } else {
            add_balls(&m);
        }
        in = input_of(&m);
        how.size = sizes[i];
        CHECK_EQUAL(pbw_solid(&in, &how, NULL, &mesh, NULL, &r), PBW_OK);
        CHECK(is_sound(&mesh) && r.bad_edges == 0 && r.bad_points == (i == 3));
        CHECK(r.euler == (i == 3 ? 3 : 4) || (i == 4 && r.euler == 2));
        CHECK(r.distance < 0.2 && r.improve.after.volume > 0.8 * r.input_volume);
        test_say("Euler %ld, distance %.3f, volume %.4f of %.4f", r.euler, r.distance, r.improve.after.volume,
                 r.input_volume);
        if (i == 2) {
            check_threads(&in, &how, &mesh);
        }
        pbw_tets_free(&mesh);
    }
    memset(&options, 0, sizeof options);
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &memory;
    how.rounds = 1;
    check_allocations(&in, &how, &options, &memory);
    test_end();
}

typedef struct signs { size_t calls, sizes; int planned; } signs;

static int count_sign(void *user, pbw_stage stage, double done)
{
    signs *s = (signs *)user;
    (void)stage;
    (void)done;
    s->calls += !s->planned;
    return s->planned;
}

static double count_size(void *user, const double p[3])
{
    (void)p;
    ((signs *)user)->sizes++;
    return 0.1;
}

static void end_at_plan(void *user, const pbw_solid_report *report)
{
    (void)report;
    ((signs *)user)->planned = 1;
}

/* Sizes are taken with signs between, however long the caller's function takes. */
static void test_signs(void)
{
    static part m;
    pbw_options options;
    pbw_solid_options how;
    pbw_solid_input in;
    pbw_tets mesh;
    signs s;
    if (!test_begin("signs while sizes are taken")) {
        return;
    }
    (void)part_make(PART_L, 0, &m);
    in = input_of(&m);
    memset(&options, 0, sizeof options);
    memset(&how, 0, sizeof how);
    memset(&s, 0, sizeof s);
    how.size = how.least_size = 0.1;
    how.size_at = count_size;
    how.plan = end_at_plan;
    how.size_user = how.plan_user = &s;
    options.threads = 1;
    options.progress = count_sign;
    options.progress_user = &s;
    CHECK_EQUAL(pbw_solid(&in, &how, &options, &mesh, NULL, NULL), PBW_CANCELLED);
    test_say("%zu signs, %zu sizes", s.calls, s.sizes);
    CHECK(s.sizes > 20000 && s.calls > s.sizes / 4096);
    test_end();
}

typedef struct stages { const char *name; char seen[64]; } stages;

static int note_stage(void *user, pbw_stage stage, double done)
{
    stages *s = (stages *)user;
    (void)done;
    if (stage != PBW_STAGE_WORK || s->name == NULL) {
        strcpy(s->seen, "none ");
    } else if (strstr(s->seen, s->name) == NULL && strlen(s->seen) < 32) {
        strcat(strcat(s->seen, s->name), " ");
    }
    return 0;
}

/* At 30 levels of options.memory_limit a call holds at most that, and makes the same solid or none; kind 1: a second
   attempt, while the first is held. */
static void test_limits(int kind)
{
    static const double low[3] = { 0, 0, 0 }, near[3] = { 2, 2, 2 }, after[3] = { 2.02, 0, 0 };
    static const double high[3] = { 4, 2, 2 };
    part m;
    pbw_solid_input in;
    pbw_solid_options how;
    pbw_solid_boundary boundary;
    pbw_options options;
    pbw_tets mesh, whole;
    meter memory;
    size_t most = 0, k, enough = 0;
    if (!test_begin("memory limits%s", kind == 1 ? ", two attempts" : "")) {
        return;
    }
    (void)part_make(PART_L, 0, &m);
    m.triangles -= kind == 0;                        /* a hole to close */
    if (kind == 1) {                                 /* two boxes that nearly touch: they grow together */
        m.points = m.triangles = 0;
        (void)part_box(&m, low, near, 0);
        (void)part_box(&m, after, high, 0);
    }
    in = input_of(&m);
    memset(&options, 0, sizeof options);
    memset(&how, 0, sizeof how);
    memset(&whole, 0, sizeof whole);
    how.size = kind == 1 ? 1 : 0.2;
    how.least_size = kind == 1 ? 0.3 : 0;
    how.rounds = kind == 1 ? 2 : 0;
    how.improve.target = kind == 1 ? -1 : 0;
    how.improve.passes = 1;
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &memory;
    for (k = 0; k <= 30; k++) {                      /* to 1.5 times what it holds without a limit */
        pbw_status status;
        meter_start(&memory, 0, 0);
        options.memory_limit = most * k / 20;
        status = pbw_solid(&in, &how, &options, &mesh, &boundary, NULL);
        if (k == 0) {
            CHECK_EQUAL(status, PBW_OK);
            most = memory.peak;
            whole.tet_count = mesh.tet_count;
            whole.point_count = mesh.point_count;
        } else if (!CHECK(memory.peak <= options.memory_limit)) {
            test_say("%.3f of the limit", (double)memory.peak / (double)options.memory_limit);
        }
        CHECK(status == PBW_OK ? mesh.tet_count == whole.tet_count && mesh.point_count == whole.point_count
              : status == PBW_ERROR_MEMORY && mesh.points == NULL && boundary.facets == NULL);
        enough += status == PBW_OK;
        pbw_solid_boundary_free(&boundary);
        pbw_tets_free(&mesh);
        CHECK(memory.blocks == 0 && memory.faults == 0);
    }
    test_say("holds %zu bytes, makes %zu tetrahedra; %zu of 30 limits suffice", most, whole.tet_count, enough - 1);
    CHECK(enough > 5 && enough < 18);
    test_end();
}

static void test_stages(void)
{
    static part m;
    pbw_options options;
    pbw_solid_options how;
    pbw_solid_input in;
    pbw_tets mesh;
    stages s;
    if (!test_begin("each stage has its name while it is at work")) {
        return;
    }
    (void)part_make(PART_L, 0, &m);
    in = input_of(&m);
    memset(&options, 0, sizeof options);
    memset(&how, 0, sizeof how);
    memset(&s, 0, sizeof s);
    how.size = 1.2;
    how.stage = &s.name;
    options.progress = note_stage;
    options.progress_user = &s;
    CHECK(pbw_solid(&in, &how, &options, &mesh, NULL, NULL) == PBW_OK);
    CHECK(strcmp(s.seen, "sample rounds improve measure ") == 0);
    pbw_tets_free(&mesh);
    test_end();
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 1);
    test_functions();
    test_edges();
    test_threads();
    test_distance();
    test_models();
    test_features();
    test_tip();
    test_pits();
    test_horns();
    test_tips_let_go();
    test_creases();
    test_missing();
    test_nearly_common_faces();
    test_gaps();
    test_acute();
    test_thin();
    test_plate();
    test_stuffing();
    test_stuffing_fails();
    test_regions();
    test_sheets();
    test_walls();
    test_unions();
    test_touching();
    test_joints();
    test_planes();
    test_sharp();
    test_refusals();
    test_cut_ball();
    test_patches();
    test_sizes();
    test_region_sizes();
    test_holes();
    test_warnings();
    test_stages();
    test_signs();
    test_places();
    test_failures();
    test_limits(0);
    test_limits(1);
    return test_finish();
}
