/* test_wrap.c: wraps are closed, oriented manifolds that strictly enclose what they wrap, by an exact check of
   wraps.h: soups, flat and repeated elements, points and segments; cavities, alpha by place, shells and the alpha
   that closes them; good tetrahedra in wraps; refusals; the same bytes for every number of threads; sound after every
   failure. */
#include <time.h>

static clock_t test_time(void);
#define clock test_time                              /* the headers' time is what a test says */
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_WRAP_IMPLEMENTATION
#include "pbw_wrap.h"
#undef clock
#include "meter.h"
#include "test.h"
#include "watch.h"
#include "wraps.h"

/* Checks a wrap; returns its number of facets. */
static size_t check_wrap(const char *name, const pbw_wrap_input *in, const pbw_wrap_options *how)
{
    pbw_wrap_result w;
    pbw_wrap_report r;
    const pbw_status status = pbw_wrap(in, how, NULL, &w, &r);
    const char *fault = status == PBW_OK ? wraps_fault(in, &w, 20) : pbw_status_string(status);
    const size_t facets = w.facet_count;
    if (!CHECK(fault == NULL)) {
        test_say("%s: %s", name, fault);
    }
    CHECK_EQUAL(r.refusal, PBW_WRAP_DONE);
    pbw_wrap_free(&w);
    pbw_wrap_free(&w);
    return facets;
}

static void wrap_soups(void)
{
    static wraps_soup s;
    long i;
    for (i = 0; i < test_count; i++) {
        char name[40];
        snprintf(name, sizeof name, "soup %llu", (unsigned long long)test_seed + (unsigned long long)i);
        wraps_make(&s, test_seed + (uint64_t)i);
        check_wrap(name, &s.in, &s.how);
    }
}

/* ---- elements that are hardly there ---- */

static void wrap_degenerate(void)
{
    static const double x[] = { 0, 0, 0,  1, 0, 0,  0, 1, 0,  0.5, 0.5, 0,  0, 0, 0,  2, 0, 0 };
    static const pbw_index point[] = { 0 }, twice[] = { 1, 1, 0, 4 }, segment[] = { 0, 1 }, still[] = { 0, 4 };
    static const pbw_index one[] = { 0, 1, 2 }, flat[] = { 0, 1, 5, 1, 5, 0, 5, 0, 1 }, dot[] = { 0, 4, 0 };
    static const pbw_index folded[] = { 0, 0, 1, 1, 0, 1, 1, 1, 0 }, plane[] = { 0, 1, 3, 0, 3, 2, 1, 5, 3, 0, 1, 3 };
    static const struct { const char *name; const pbw_index *ids; size_t triangles, segments, singles; } cases[] = {
        { "one point", point, 0, 0, 1 }, { "points at one place", twice, 0, 0, 4 }, { "a segment", segment, 0, 1, 0 },
        { "a segment of one place", still, 0, 1, 0 }, { "a triangle", one, 1, 0, 0 },
        { "flat triangles", flat, 3, 0, 0 },
        { "a triangle of one place", dot, 1, 0, 0 }, { "triangles with a corner twice", folded, 3, 0, 0 },
        { "all in one plane", plane, 4, 0, 0 }
    };
    size_t i, k;
    for (i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (k = 0; k < 3; k++) {
            pbw_wrap_input in;
            pbw_wrap_options how;
            memset(&in, 0, sizeof in);
            memset(&how, 0, sizeof how);
            how.alpha = k == 0 ? 0.1 : k == 1 ? 3 : 0.3;
            how.offset = k == 2 ? 0.3 : 0;
            in.points = x;
            in.point_count = sizeof x / sizeof *x / 3;
            in.triangles = in.segments = in.singles = cases[i].ids;
            in.triangle_count = cases[i].triangles;
            in.segment_count = cases[i].segments;
            in.single_count = cases[i].singles;
            check_wrap(cases[i].name, &in, &how);
        }
    }
}

/* ---- shapes ---- */

enum { SIDE = 16 };

typedef struct shape {
    double x[(SIDE + 1) * 2 * SIDE * 2][3];
    pbw_index t[SIDE * 2 * SIDE * 2 * 2][3];
    size_t points, triangles;
    pbw_wrap_input in;
} shape;

/* Adds what a line of SIDE + 1 places (distance from the axis, height) sweeps around the axis. */
static void add_swept(shape *s, const double (*place)[2])
{
    const size_t first = s->points, around = 2 * SIDE;
    size_t i, k;
    for (i = 0; i <= SIDE; i++) {
        for (k = 0; k < around; k++) {
            const double v = 3.14159265358979 * (double)k / SIDE;
            double *x = s->x[s->points++];
            x[0] = place[i][0] * cos(v);
            x[1] = place[i][0] * sin(v);
            x[2] = place[i][1];
            if (i < SIDE) {
                const pbw_index a = (pbw_index)(first + i * around + k), down = 2 * SIDE;
                const pbw_index b = (pbw_index)(first + i * around + (k + 1) % around);
                pbw_index *t = s->t[s->triangles];
                t[0] = a, t[1] = a + down, t[2] = b;
                t[3] = b, t[4] = a + down, t[5] = b + down;
                s->triangles += 2;
            }
        }
    }
    s->in.points = s->x[0];
    s->in.point_count = s->points;
    s->in.triangles = s->t[0];
    s->in.triangle_count = s->triangles;
}

/* Adds a sphere around the origin, from the pole down to a part of its height: 1 = closed. */
static void add_sphere(shape *s, double radius, double part)
{
    double place[SIDE + 1][2];
    size_t i;
    for (i = 0; i <= SIDE; i++) {
        const double u = 3.14159265358979 * part * (double)i / SIDE;
        place[i][0] = i == 0 || (i == SIDE && part >= 1) ? 0 : radius * sin(u);
        place[i][1] = radius * cos(u);
    }
    add_swept(s, (const double (*)[2])place);
}

/* Adds what a line of corners sweeps around the axis. */
static void add_turned(shape *s, const double (*line)[2], size_t corners)
{
    double place[SIDE + 1][2];
    size_t i, k;
    for (i = 0; i <= SIDE; i++) {                    /* evenly: each side of the line has the same number of places */
        const double at = (double)i * (double)(corners - 1) / SIDE;
        const size_t side = at < (double)(corners - 1) ? (size_t)at : corners - 2;
        for (k = 0; k < 2; k++) {
            place[i][k] = line[side][k] + (at - (double)side) * (line[side + 1][k] - line[side][k]);
        }
    }
    add_swept(s, (const double (*)[2])place);
}

static pbw_wrap_report report_of(const shape *s, const pbw_wrap_options *how)
{
    pbw_wrap_report r;
    pbw_wrap_result w;
    CHECK_EQUAL(pbw_wrap(&s->in, how, NULL, &w, &r), PBW_OK);
    CHECK(wraps_fault(&s->in, &w, 20) == NULL);
    pbw_wrap_free(&w);
    return r;
}

/* A ball with a cavity: its inside is carved only from a seed. */
static void wrap_cavity(void)
{
    static shape s;
    static const double seeds[] = { 0, 0, 0, 0, 0, 0.55, 9, 9, 9 };
    const double ball = 4.18879;
    pbw_wrap_options how;
    pbw_wrap_report r;
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    add_sphere(&s, 1, 1);
    add_sphere(&s, 0.6, 1);
    how.alpha = 0.15;
    how.offset = 0.01;
    r = report_of(&s, &how);
    CHECK(r.volume > ball && r.volume < 1.1 * ball && r.components == 1);
    how.seeds = seeds;
    how.seed_count = 3;
    r = report_of(&s, &how);
    CHECK(r.volume < 0.9 * ball && r.volume > (1 - 0.216) * ball && r.components == 2);
    CHECK_EQUAL(r.unused_seeds, 2);
}

/* A cup: a shell, until alpha is above the radius of its opening. */
static void wrap_shell(void)
{
    static shape s;
    pbw_wrap_options how;
    pbw_wrap_report r;
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    add_sphere(&s, 1, 0.8);
    how.alpha = 0.1;
    how.closing = 1;
    r = report_of(&s, &how);
    CHECK(r.shell && r.open_edges == 2 * SIDE && r.volume < 1);
    CHECK(r.closing > 0.3 && r.closing < 0.9);
    how.alpha = r.closing;
    r = report_of(&s, &how);
    CHECK(!r.shell && r.volume > 4);
    memset(&s, 0, sizeof s);
    add_sphere(&s, 1, 1);
    how.alpha = 0.1;
    r = report_of(&s, &how);
    CHECK(!r.shell && r.open_edges == 0 && !(r.closing > 0));
}

/* What is a shell, from fine wraps to those much coarser than the model. */
static void tell_shells(void)
{
    static const struct {
        const char *name;
        double line[6][2];
        size_t corners;
        double shell[2], closed[3];                  /* alphas; 0: no more */
    } cases[] = {
        { "bottle", { { 0, 0 }, { 1, 0 }, { 1, 2 }, { .2, 2.5 }, { .2, 3.5 } }, 5, { .1, .18 }, { .25, 1, 5 } },
        { "cup", { { 0, 0 }, { 1, 0 }, { 1.2, 2 } }, 3, { .2, .8 }, { 1.3, 5, 20 } },
        { "box without a lid", { { 0, 0 }, { .5, 0 }, { .5, 1 } }, 3, { .1, .3 }, { .55, 3, 20 } },
        { "tray", { { 0, 0 }, { 5, 0 }, { 5, 1 } }, 3, { .5, 1 }, { 14, 40, 0 } },
        { "thin box with a hole", { { 1, 1 }, { 5, 1 }, { 5, 0 }, { 0, 0 } }, 4, { .4, 0 }, { 1.2, 5, 20 } },
        { "tube", { { 1, 0 }, { 1, 3 } }, 2, { .3, .9 }, { 1.2, 6, 0 } },
        { "sheet", { { 0, 0 }, { 1, 0 } }, 2, { .1, .5 }, { 0, 0, 0 } },
        { "dish", { { 0, 0 }, { .5, .05 }, { 1, .2 } }, 3, { .1, .9 }, { 0, 0, 0 } },
        { "gutter", { { 2, 1 }, { 2, 0 }, { 3, 0 }, { 3, 1 } }, 4, { .2, .4 }, { .6, 3, 9 } },
        { "torus with a slot", { { 2.3, 1 }, { 2, 1 }, { 2, 0 }, { 3, 0 }, { 3, 1 }, { 2.7, 1 } }, 6, { .15, 0 },
          { .25, 1, 9 } }
    };
    static shape s;
    size_t i, k;
    for (i = 0; i < sizeof cases / sizeof *cases; i++) {
        memset(&s, 0, sizeof s);
        add_turned(&s, cases[i].line, cases[i].corners);
        for (k = 0; k < 5; k++) {
            pbw_wrap_options how;
            pbw_wrap_report r;
            pbw_wrap_result w;
            memset(&how, 0, sizeof how);
            how.alpha = k < 2 ? cases[i].shell[k] : cases[i].closed[k - 2];
            if (how.alpha > 0 && CHECK(pbw_wrap(&s.in, &how, NULL, &w, &r) == PBW_OK)) {
                if (!CHECK(r.shell == (k < 2) && r.open_edges > 0)) {
                    test_say("%s, alpha %g: %g on both sides", cases[i].name, how.alpha, r.both_sides);
                }
                pbw_wrap_free(&w);
            }
        }
    }
}

/* The alpha that closes a model closes all of it; none closes a sheet.  Points have no open edges. */
static void close_all(void)
{
    static const double sheet[2][2] = { { 0, 0 }, { 1, 0 } };
    static const double small[4][2] = { { 0, 0 }, { 1, 0 }, { 1, 2 }, { .2, 2 } };
    static const double large[4][2] = { { 3, 0 }, { 2, 0 }, { 2, 2 }, { 2.3, 2 } };
    static shape s;
    static pbw_index all[2 * (SIDE + 1) * 2 * SIDE];
    pbw_wrap_options how;
    pbw_wrap_report r;
    size_t i;
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    how.closing = 1;
    add_turned(&s, sheet, 2);
    how.alpha = 0.2;
    r = report_of(&s, &how);
    CHECK(r.shell && r.both_sides > 0.9 && !(r.closing > 0));
    memset(&s, 0, sizeof s);
    add_turned(&s, small, 4);                        /* a pot that alphas above 0.2 close, in a gutter: above 0.6 */
    add_turned(&s, large, 4);
    how.alpha = 0.15;
    r = report_of(&s, &how);
    CHECK(r.shell && r.closing > 0.5 && r.closing < 2);
    memset(&s, 0, sizeof s);
    add_sphere(&s, 1, 0.8);
    for (i = 0; i < s.points; i++) {
        all[i] = (pbw_index)i;
    }
    s.in.singles = all;
    s.in.single_count = s.points;
    s.in.triangle_count = 0;
    how.alpha = 0.3;
    r = report_of(&s, &how);
    CHECK(r.shell && r.open_edges == 0 && r.closing > 0.5 && r.closing < 0.9);
    how.alpha = 4;
    CHECK_EQUAL(report_of(&s, &how).shell, 0);
}

/* ---- solids ---- */

static void fill_closed(void)
{
    static shape s;
    const double ball = 4.18879;
    pbw_wrap_solid_options how;
    pbw_wrap_solid_report r;
    pbw_tets mesh;
    int stay;
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    add_sphere(&s, 1, 1);
    how.size = 0.4;
    for (stay = 0; stay < 2; stay++) {
        how.stay = stay;
        if (CHECK(pbw_wrap_solid(&s.in, &how, NULL, &mesh, &r) == PBW_OK)) {
            CHECK(r.closed && !r.late && !(r.raised > 0) && r.improve.after.least > 20);
            CHECK(r.before[0] > 0.04 && r.before[1] > 0.04 && r.after[0] >= 0 && r.after[0] < 0.2);
            CHECK(stay ? r.improve.after.volume > 1.1 * ball : fabs(r.improve.after.volume / ball - 1) < 0.05);
            CHECK(mesh.tet_count > 200 && r.tets > 200 && r.size >= 0.4);
        }
        pbw_tets_free(&mesh);
    }
}

/* Alpha is raised where a little closes the model, and for points. */
static void fill_open(void)
{
    static shape s;
    static pbw_index all[2 * (SIDE + 1) * 2 * SIDE];
    pbw_wrap_solid_options how;
    pbw_wrap_solid_report r;
    pbw_tets mesh;
    size_t i;
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    add_sphere(&s, 1, 0.87);                         /* a hole of radius 0.397, less the offset */
    how.size = 0.5;
    CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, NULL, &mesh, &r), PBW_OK);
    CHECK(r.raised > 0.249 && r.raised < 0.251 && r.wrap.alpha > 0.3 && r.wrap.alpha < 0.376);
    CHECK(!r.closed && !r.wrap.shell && r.improve.after.volume > 3.8);
    pbw_tets_free(&mesh);
    how.size = 0.3;
    CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, NULL, &mesh, &r), PBW_OK);
    CHECK(!(r.raised > 0) && r.wrap.shell && r.improve.after.volume < 2);
    pbw_tets_free(&mesh);
    for (i = 0; i < s.points; i++) {
        all[i] = (pbw_index)i;
    }
    s.in.singles = all;
    s.in.single_count = s.points;
    s.in.triangle_count = 0;
    CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, NULL, &mesh, &r), PBW_OK);
    CHECK(r.raised > 0.149 && r.raised < 0.151 && r.wrap.alpha > 0.25 && !r.closed && r.improve.after.volume > 3.8);
    pbw_tets_free(&mesh);
}

static clock_t time_now;                             /* what test_time returns; it advances by one tick a call */

static clock_t test_time(void)
{
    return time_now++;
}

typedef struct slow {                                /* progress that lets the time pass in a stage */
    const char *stage, *last;
    double seconds;                                  /* that pass in the stage "improve" */
    double done;
    int fell;
} slow;

static int pass_time(void *user, pbw_stage stage, double done)
{
    slow *t = (slow *)user;
    (void)stage;
    t->fell |= done < t->done;
    t->done = done;
    if (t->stage != NULL && t->stage != t->last && strcmp(t->stage, "improve") == 0) {
        time_now += (clock_t)(t->seconds * CLOCKS_PER_SEC);
    }
    t->last = t->stage;
    return 0;
}

/* Improvement that has no time left keeps what it has; stages follow each other. */
static void fill_late(void)
{
    static shape s;
    pbw_wrap_solid_options how;
    pbw_wrap_solid_report r;
    pbw_options options;
    pbw_tets mesh;
    slow t;
    memset(&s, 0, sizeof s);
    memset(&t, 0, sizeof t);
    memset(&how, 0, sizeof how);
    memset(&options, 0, sizeof options);
    add_sphere(&s, 1, 1);
    how.size = 0.5;
    how.stage = &t.stage;
    how.seconds = 100;
    options.threads = 1;
    options.progress = pass_time;
    options.progress_user = &t;
    CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, &options, &mesh, &r), PBW_OK);
    CHECK(!r.late && r.after[0] >= 0 && t.done > 0.99 && !t.fell && strcmp(t.stage, "measure") == 0);
    pbw_tets_free(&mesh);
    t.seconds = 101;
    t.done = 0;
    CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, &options, &mesh, &r), PBW_OK);
    CHECK(r.late && r.before[0] > 0 && !(r.after[0] >= 0) && mesh.tet_count > 100);
    pbw_tets_free(&mesh);
    how.seconds = 1e-9;
    CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, NULL, &mesh, &r), PBW_CANCELLED);
    CHECK(r.wrap.refusal == PBW_WRAP_LATE && mesh.tet_count == 0);
    how.seconds = 0;
    how.size = (double)NAN;
    CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, NULL, &mesh, &r), PBW_ERROR_ARGUMENT);
    how.size = 0;
    s.x[3][1] = (double)NAN;
    CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, NULL, &mesh, NULL), PBW_ERROR_NOT_FINITE);
    s.x[3][1] = 0;
    s.t[5][1] = 1000000;
    CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, NULL, &mesh, NULL), PBW_ERROR_ARGUMENT);
    s.in.triangle_count = 0;
    CHECK_EQUAL(pbw_wrap_solid(&s.in, NULL, NULL, &mesh, &r), PBW_DEGENERATE);
    CHECK_EQUAL(r.wrap.refusal, PBW_WRAP_EMPTY);
    CHECK_EQUAL(pbw_wrap_solid(&s.in, NULL, NULL, NULL, &r), PBW_ERROR_ARGUMENT);
}

static double finer_above(void *user, const double p[3])
{
    ++*(long *)user;
    return p[2] > 0 ? 0.1 : 1;
}

static void wrap_by_place(void)
{
    static shape s;
    pbw_wrap_options how;
    pbw_wrap_result w;
    long calls = 0;
    size_t f, above = 0;
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    add_sphere(&s, 1, 1);
    how.alpha = 0.3;
    how.offset = 0.01;
    how.alpha_at = finer_above;
    how.alpha_user = &calls;
    CHECK_EQUAL(pbw_wrap(&s.in, &how, NULL, &w, NULL), PBW_OK);
    CHECK(wraps_fault(&s.in, &w, 20) == NULL);
    for (f = 0; f < w.facet_count; f++) {
        above += w.points[3 * (size_t)w.facets[3 * f] + 2] > 0;
    }
    if (!CHECK(above > 2 * (w.facet_count - above) && calls > 100)) {
        test_say("%lu of %lu facets, %ld calls", (unsigned long)above, (unsigned long)w.facet_count, calls);
    }
    pbw_wrap_free(&w);
}

/* Facets have the nearest elements, by trying all; distances are those of vertices at the offset. */
static void find_elements(void)
{
    static wraps_soup s;
    pbw_wrap_result w;
    pbw_wrap_report r;
    double distance[2], p[3], q[3];
    size_t f, e, k;
    wraps_make(&s, 7);
    CHECK_EQUAL(pbw_wrap(&s.in, &s.how, NULL, &w, &r), PBW_OK);
    for (f = 0; f < w.facet_count; f++) {
        double best = HUGE_VAL, own = HUGE_VAL;
        for (k = 0; k < 3; k++) {
            p[k] = (w.points[3 * (size_t)w.facets[3 * f] + k] + w.points[3 * (size_t)w.facets[3 * f + 1] + k]
                    + w.points[3 * (size_t)w.facets[3 * f + 2] + k]) / 3;
        }
        for (e = 0; e < wraps_elements(&s.in); e++) {
            const double *c[3];
            double d;
            wraps_element(&s.in, e, c);
            pbwsf__nearest_in(c[0], c[1], c[2], p, q);
            d = sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2]));
            best = fmin(best, d);
            own = e == w.elements[f] ? d : own;
        }
        CHECK(own <= best * (1 + 1e-9));
    }
    CHECK_EQUAL(pbw_wrap_distance(&s.in, w.points, w.point_count, w.facets, w.facet_count, NULL, distance), PBW_OK);
    CHECK(distance[0] >= r.offset * 0.999 && distance[0] < r.offset + 3 * r.alpha);
    CHECK(distance[1] > 0 && distance[1] < r.offset + 3 * r.alpha);
    pbw_wrap_free(&w);
}

/* Vertices inside leave the surface as it is. */
static void fill(void)
{
    static shape s;
    pbw_wrap_options how;
    pbw_wrap_result w, filled;
    size_t t, i, k, coarse[2] = { 0, 0 };
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    add_sphere(&s, 1, 0.9);
    how.alpha = 0.4;
    CHECK_EQUAL(pbw_wrap(&s.in, &how, NULL, &w, NULL), PBW_OK);
    how.fill = 0.2;
    CHECK_EQUAL(pbw_wrap(&s.in, &how, NULL, &filled, NULL), PBW_OK);
    CHECK(wraps_fault(&s.in, &filled, 20) == NULL);
    CHECK_EQUAL(filled.vertex_count, w.vertex_count);
    CHECK_EQUAL(filled.facet_count, w.facet_count);
    CHECK(memcmp(filled.points, w.points, 24 * w.vertex_count) == 0);
    for (k = 0; k < 2; k++) {
        const pbw_wrap_result *r = k == 0 ? &w : &filled;
        for (t = 0; t < r->tet_count; t++) {
            for (i = 0; i < 3; i++) {
                const double *a = r->points + 3 * (size_t)r->corners[4 * t + i];
                const double *b = r->points + 3 * (size_t)r->corners[4 * t + i + 1];
                coarse[k] += sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])
                                  + (a[2] - b[2]) * (a[2] - b[2])) > 1;
            }
        }
    }
    CHECK(filled.point_count > 2 * w.point_count && coarse[0] > 10 && coarse[1] < coarse[0] / 4);
    pbw_wrap_free(&w);
    pbw_wrap_free(&filled);
}

/* ---- refusals ---- */

static void check_refusal(const double *x, size_t points, double alpha, double offset, pbw_status status, int refusal)
{
    static const pbw_index ids[] = { 0, 1, 2 };
    pbw_wrap_input in;
    pbw_wrap_options how;
    pbw_wrap_result w;
    pbw_wrap_report r;
    memset(&in, 0, sizeof in);
    memset(&how, 0, sizeof how);
    in.points = x;
    in.point_count = points;
    in.triangles = ids;
    in.triangle_count = points > 0;
    how.alpha = alpha;
    how.offset = offset;
    CHECK_EQUAL(pbw_wrap(&in, &how, NULL, &w, &r), status);
    CHECK_EQUAL(r.refusal, refusal);
    CHECK(w.memory == NULL && w.facet_count == 0);
}

static void refuse(void)
{
    static const double here[9] = { 1, 1, 1, 1, 1, 1, 1, 1, 1 };
    static const double far[9] = { 1e12, 0, 0, 1e12, 1, 0, 1e12, 0, 1 };
    static const double wide[9] = { 0, 0, 0, 1e200, 0, 0, 0, 1e200, 0 };
    double x[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    pbw_wrap_input in;
    pbw_wrap_options how;
    pbw_wrap_result w;
    pbw_wrap_report r;
    check_refusal(x, 0, 0, 0, PBW_DEGENERATE, PBW_WRAP_EMPTY);
    check_refusal(here, 3, 0, 0, PBW_DEGENERATE, PBW_WRAP_NO_SIZE);
    check_refusal(far, 3, 0, 0, PBW_ERROR_ARGUMENT, PBW_WRAP_NEAR);
    check_refusal(x, 3, 0.1, 1e-10, PBW_ERROR_ARGUMENT, PBW_WRAP_NEAR);
    check_refusal(wide, 3, 0, 0, PBW_ERROR_ARGUMENT, PBW_WRAP_DONE);
    check_refusal(x, 2, 0.1, 0, PBW_ERROR_ARGUMENT, PBW_WRAP_DONE);
    check_refusal(x, 3, -1, 0, PBW_ERROR_ARGUMENT, PBW_WRAP_DONE);
    check_refusal(x, 3, 0.1, (double)NAN, PBW_ERROR_ARGUMENT, PBW_WRAP_DONE);
    x[4] = (double)NAN;
    check_refusal(x, 3, 0.1, 0, PBW_ERROR_NOT_FINITE, PBW_WRAP_DONE);
    x[4] = HUGE_VAL;
    check_refusal(x, 3, 0.1, 0, PBW_ERROR_NOT_FINITE, PBW_WRAP_DONE);
    memset(&in, 0, sizeof in);
    memset(&how, 0, sizeof how);
    in.singles = (const pbw_index *)x;                   /* all zero bytes */
    x[4] = x[0] = 0;
    in.points = here;
    in.point_count = 3;
    in.single_count = 1;
    how.alpha = 1;
    how.most = 10;
    how.offset = 1e-2;
    CHECK_EQUAL(pbw_wrap(&in, &how, NULL, &w, &r), PBW_ERROR_TOO_LARGE);
    CHECK_EQUAL(r.refusal, PBW_WRAP_LARGE);
    how.most = 0;
    how.seconds = 1e-9;
    CHECK_EQUAL(pbw_wrap(&in, &how, NULL, &w, &r), PBW_CANCELLED);
    CHECK_EQUAL(r.refusal, PBW_WRAP_LATE);
    CHECK(w.memory == NULL);
    CHECK_EQUAL(pbw_wrap(NULL, &how, NULL, &w, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_wrap(&in, &how, NULL, NULL, NULL), PBW_ERROR_ARGUMENT);
}

/* All functions refuse the input with these options. */
static void check_wrong(const pbw_wrap_input *in, const pbw_wrap_solid_options *how, pbw_status status)
{
    static const double x[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    static const pbw_index ids[] = { 0, 1, 2 };
    pbw_wrap_result w;
    pbw_tets mesh;
    double distance[2];
    CHECK_EQUAL(pbw_wrap(in, &how->wrap, NULL, &w, NULL), status);
    CHECK(w.memory == NULL && w.facet_count == 0);
    CHECK_EQUAL(pbw_wrap_solid(in, how, NULL, &mesh, NULL), status);
    CHECK(mesh.memory == NULL && mesh.tet_count == 0);
    CHECK_EQUAL(pbw_wrap_distance(in, x, 3, ids, 1, NULL, distance), status);
}

/* Arrays that are not there, counts that nothing can have, numbers that are none. */
static void refuse_wrong(void)
{
    static const double x[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, wrong[] = { -1, -HUGE_VAL, NAN };
    static const pbw_index ids[] = { 0, 1, 2 };
    const size_t huge[] = { PBW_NONE, (size_t)-1, (size_t)-1 / 3 + 1 };
    pbw_wrap_input good, in;
    pbw_wrap_solid_options how;
    pbw_tets mesh;
    double distance[2];
    size_t i, k;
    memset(&good, 0, sizeof good);
    memset(&how, 0, sizeof how);
    good.points = x;
    good.point_count = 3;
    good.triangles = good.segments = good.singles = ids;
    good.triangle_count = good.segment_count = good.single_count = 1;
    for (i = 0; i < 4; i++) {
        in = good;
        in.points = i == 0 ? NULL : x;
        in.triangles = i == 1 ? NULL : ids;
        in.segments = i == 2 ? NULL : ids;
        in.singles = i == 3 ? NULL : ids;
        check_wrong(&in, &how, PBW_ERROR_ARGUMENT);
    }
    for (i = 0; i < 3; i++) {
        for (k = 0; k < 3; k++) {
            in = good;
            *(i == 0 ? &in.triangle_count : i == 1 ? &in.segment_count : &in.single_count) = huge[k];
            check_wrong(&in, &how, PBW_ERROR_TOO_LARGE);
        }
        for (k = 0; k < 9; k++) {
            double *const number[] = { &how.wrap.alpha, &how.wrap.offset, &how.wrap.fill, &how.wrap.most,
                                       &how.wrap.seconds, &how.size, &how.target, &how.seconds };
            pbw_wrap_result w;
            memset(&how, 0, sizeof how);
            if (k < 8) {
                *number[k] = wrong[i];
                CHECK_EQUAL(pbw_wrap_solid(&good, &how, NULL, &mesh, NULL), PBW_ERROR_ARGUMENT);
            } else {
                how.wrap.seed_count = 1;
            }
            if (k < 5 || k == 8) {
                CHECK_EQUAL(pbw_wrap(&good, &how.wrap, NULL, &w, NULL), PBW_ERROR_ARGUMENT);
            }
        }
        memset(&how, 0, sizeof how);
    }
    CHECK_EQUAL(pbw_wrap_distance(NULL, x, 3, ids, 1, NULL, distance), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_wrap_distance(&good, NULL, 3, ids, 1, NULL, distance), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_wrap_distance(&good, x, 3, NULL, 1, NULL, distance), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_wrap_distance(&good, x, 3, ids, 0, NULL, distance), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_wrap_distance(&good, x, 2, ids, 1, NULL, distance), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_wrap_distance(&good, x, 3, ids, 1, NULL, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_wrap_solid(NULL, &how, NULL, &mesh, NULL), PBW_ERROR_ARGUMENT);
}

/* ---- threads, memory, cancelling ---- */

static uint64_t hash_of(uint64_t hash, const void *at, size_t bytes)
{
    size_t i;
    for (i = 0; i < bytes; i++) {
        hash = (hash ^ ((const unsigned char *)at)[i]) * UINT64_C(0x100000001b3);
    }
    return hash;
}

static uint64_t hash_result(const pbw_wrap_result *w)
{
    uint64_t hash = hash_of(1, w->points, 24 * w->point_count);
    hash = hash_of(hash, w->facets, 12 * w->facet_count);
    hash = hash_of(hash, w->elements, 4 * w->facet_count);
    hash = hash_of(hash, w->corners, 16 * w->tet_count);
    return hash_of(hash, w->neighbors, 16 * w->tet_count);
}

static uint64_t hash_wrap(const pbw_wrap_input *in, const pbw_wrap_options *how, const pbw_options *options)
{
    pbw_wrap_result w;
    uint64_t hash;
    CHECK_EQUAL(pbw_wrap(in, how, options, &w, NULL), PBW_OK);
    hash = hash_result(&w);
    pbw_wrap_free(&w);
    return hash;
}

/* A job system with one thread, which begins with the last task. */
static void run_backwards(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    *(long *)user += tasks;
    while (tasks-- > 0) {
        task(arg, tasks);
    }
}

static void run_threads(void)
{
    static shape s;
    static const int threads[] = { 2, 3, 8 };
    pbw_wrap_options how;
    pbw_options options;
    uint64_t hash;
    long tasks = 0;
    size_t i;
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    memset(&options, 0, sizeof options);
    add_sphere(&s, 1, 0.7);
    how.alpha = 0.2;
    options.threads = 1;
    hash = hash_wrap(&s.in, &how, &options);
    for (i = 0; i < 3; i++) {
        options.threads = threads[i];
        CHECK(hash_wrap(&s.in, &how, &options) == hash);
    }
    options.run = run_backwards;
    options.run_user = &tasks;
    CHECK(hash_wrap(&s.in, &how, &options) == hash && tasks > 100);
}

typedef struct asked { long before, after; } asked;      /* questions while it carves, and later */

static int count_questions(void *user, pbw_stage stage, double done)
{
    asked *a = (asked *)user;
    (void)stage;
    *(done < 0.9 ? &a->before : &a->after) += 1;
    return 0;
}

/* Carving asks before each 16 verdicts.  Passes over all tetrahedra, of which there are eight once it is carved, ask
   after each 1,024 of them. */
static void ask_often(void)
{
    static shape s;
    pbw_wrap_options how;
    pbw_wrap_result w;
    pbw_wrap_report r;
    pbw_options options;
    asked a = { 0, 0 };
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    memset(&options, 0, sizeof options);
    add_sphere(&s, 1, 1);
    how.alpha = 0.04;
    options.threads = 1;
    options.progress = count_questions;
    options.progress_user = &a;
    CHECK_EQUAL(pbw_wrap(&s.in, &how, &options, &w, &r), PBW_OK);
    test_say("%zu tetrahedra: %ld questions, then %ld", w.tet_count, a.before, a.after);
    CHECK((size_t)a.before > (r.crossings + r.projections + r.carved) / 32);
    CHECK(w.tet_count > 10000 && (size_t)a.after > 8 * w.tet_count / 1024);
    pbw_wrap_free(&w);
}

/* Options of calls that m counts and eye watches. */
static pbw_options watched(int threads, meter *m, watch *eye)
{
    pbw_options options;
    memset(&options, 0, sizeof options);
    options.threads = threads;
    options.resize = meter_resize;
    options.resize_user = m;
    options.progress = watch_progress;
    options.progress_user = eye;
    meter_start(m, 0, 0);
    watch_start(eye, 0);
    return options;
}

static void fail_everywhere(void)
{
    static wraps_soup s;
    pbw_wrap_result w;
    pbw_options options;
    meter m;
    watch eye;
    double distance[2];
    long requests, i, calls;
    size_t peak;
    wraps_make(&s, 7);
    options = watched(1, &m, &eye);
    CHECK_EQUAL(pbw_wrap(&s.in, &s.how, &options, &w, NULL), PBW_OK);
    CHECK_EQUAL(eye.wrong, 0);
    CHECK(eye.done >= 1 && w.facet_count > 50);
    requests = m.requests;
    peak = m.peak;
    calls = eye.calls;
    watch_start(&eye, 0);
    CHECK_EQUAL(pbw_wrap_distance(&s.in, w.points, w.point_count, w.facets, w.facet_count, &options, distance),
                PBW_OK);
    pbw_wrap_free(&w);
    CHECK_EQUAL(m.blocks, 0);
    for (i = 1; i <= requests; i++) {
        meter_start(&m, i, i % 2 == 0);
        watch_start(&eye, 0);
        CHECK_EQUAL(pbw_wrap(&s.in, &s.how, &options, &w, NULL), PBW_ERROR_MEMORY);
        CHECK(w.memory == NULL && m.blocks == 0 && m.faults == 0);
    }
    for (i = 1; i <= 16; i++) {
        meter_start(&m, 0, 0);
        watch_start(&eye, 0);
        options.memory_limit = peak * (size_t)i / 16;
        CHECK_EQUAL(pbw_wrap(&s.in, &s.how, &options, &w, NULL), i < 16 ? PBW_ERROR_MEMORY : PBW_OK);
        CHECK(m.peak <= options.memory_limit);
        pbw_wrap_free(&w);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    options.memory_limit = 0;
    for (i = 1; i <= calls; i += 1 + calls / 40) {
        meter_start(&m, 0, 0);
        watch_start(&eye, i);
        CHECK_EQUAL(pbw_wrap(&s.in, &s.how, &options, &w, NULL), PBW_CANCELLED);
        CHECK(eye.calls == i && m.blocks == 0);
    }
}

/* Eight threads: allocations that fail, memory limits, and callers that cancel.  The order of allocations differs
   from run to run, and a call may succeed without one of them. */
static void fail_on_threads(void)
{
    static shape s;
    pbw_wrap_options how;
    pbw_wrap_result w;
    pbw_options options;
    meter m;
    watch eye;
    uint64_t hash;
    long requests, i, ended = 0;
    size_t peak;
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    add_sphere(&s, 1, 0.7);
    how.alpha = 0.3;
    options = watched(8, &m, &eye);
    hash = hash_wrap(&s.in, &how, &options);
    requests = m.requests;
    peak = m.peak;
    for (i = 0; i < 90; i++) {                           /* an allocation, the limit, an answer */
        pbw_status status;
        meter_start(&m, i % 3 == 0 ? 1 + i * requests / 90 : 0, (int)(i % 2));
        watch_start(&eye, i % 3 == 2 ? 1 + i : 0);
        options.memory_limit = i % 3 == 1 ? peak * (size_t)i / 90 : 0;
        status = pbw_wrap(&s.in, &how, &options, &w, NULL);
        CHECK(status == PBW_OK || status == (i % 3 == 2 ? PBW_CANCELLED : PBW_ERROR_MEMORY));
        CHECK(status == PBW_OK ? hash_result(&w) == hash : w.memory == NULL && m.blocks == 0);
        CHECK(i % 3 != 1 || m.peak <= options.memory_limit);
        pbw_wrap_free(&w);
        CHECK(m.blocks == 0 && m.faults == 0);
        ended += status != PBW_OK;
    }
    CHECK(ended > 60);
}

/* pbw_wrap_solid: the same mesh for every number of threads; it fails at any allocation, at every memory limit below
   its need, and ends where it is told to. */
static void fail_solids(void)
{
    static shape s;
    pbw_wrap_solid_options how;
    pbw_tets mesh;
    pbw_options options;
    meter m;
    watch eye;
    pbw_wrap_solid_report r;
    pbw_status status;
    uint64_t hash = 0;
    long requests, i, calls;
    size_t peak;
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    memset(&options, 0, sizeof options);
    add_sphere(&s, 1, 1);
    how.size = 1;
    for (i = 1; i < 4; i++) {
        uint64_t other;
        options.threads = (int)i;
        CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, &options, &mesh, NULL), PBW_OK);
        other = hash_of(hash_of(1, mesh.points, 24 * mesh.point_count), mesh.corners, 16 * mesh.tet_count);
        CHECK(i == 1 || other == hash);
        hash = other;
        pbw_tets_free(&mesh);
    }
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &m;
    options.progress = watch_progress;
    options.progress_user = &eye;
    meter_start(&m, 0, 0);
    watch_start(&eye, 0);
    CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, &options, &mesh, NULL), PBW_OK);
    CHECK(eye.wrong == 0 && m.blocks > 0);
    pbw_tets_free(&mesh);
    CHECK_EQUAL(m.blocks, 0);
    requests = m.requests;
    peak = m.peak;
    calls = eye.calls;
    for (i = 1; i <= requests; i += 1 + requests / 100) {
        meter_start(&m, i, i % 2 == 0);
        watch_start(&eye, 0);
        status = pbw_wrap_solid(&s.in, &how, &options, &mesh, &r);
        CHECK(status == PBW_ERROR_MEMORY ? mesh.memory == NULL
              : status == PBW_OK && !(r.improve.before.percent > 0 && r.improve.after.percent > 0));
        pbw_tets_free(&mesh);                        /* only the report's angles may lack memory */
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    for (i = 1; i <= 16; i++) {
        meter_start(&m, 0, 0);
        watch_start(&eye, 0);
        options.memory_limit = peak * (size_t)i / 16;
        CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, &options, &mesh, NULL), i < 16 ? PBW_ERROR_MEMORY : PBW_OK);
        CHECK(m.peak <= options.memory_limit);
        pbw_tets_free(&mesh);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    options.memory_limit = 0;
    for (i = 1; i <= calls; i += 1 + calls / 20) {
        meter_start(&m, 0, 0);
        watch_start(&eye, i);
        CHECK_EQUAL(pbw_wrap_solid(&s.in, &how, &options, &mesh, NULL), PBW_CANCELLED);
        CHECK(eye.calls == i && m.blocks == 0);
    }
}

/* The check of this file sees faults. */
static void see_faults(void)
{
    static shape s;
    pbw_wrap_options how;
    pbw_wrap_result w, other;
    pbw_index *facets, swapped;
    double *points;
    memset(&s, 0, sizeof s);
    memset(&how, 0, sizeof how);
    add_sphere(&s, 1, 1);
    how.alpha = 0.3;
    CHECK_EQUAL(pbw_wrap(&s.in, &how, NULL, &w, NULL), PBW_OK);
    facets = (pbw_index *)malloc(12 * w.facet_count);
    points = (double *)malloc(24 * w.point_count);
    if (CHECK(facets != NULL && points != NULL)) {
        memcpy(facets, w.facets, 12 * w.facet_count);
        memcpy(points, w.points, 24 * w.point_count);
        other = w;
        other.facets = facets;
        other.points = points;
        CHECK(wraps_fault(&s.in, &other, 20) == NULL);
        swapped = facets[0];                             /* a facet turned inward */
        facets[0] = facets[1];
        facets[1] = swapped;
        CHECK(wraps_fault(&s.in, &other, 20) != NULL);
        memcpy(facets, w.facets, 12 * w.facet_count);
        other.facet_count--;                             /* a hole */
        CHECK(!wraps_is_manifold(&other));
        other.facet_count++;
        memcpy(points, s.x[5 * 2 * SIDE], sizeof s.x[0]);                /* a vertex on the sphere */
        CHECK(wraps_fault(&s.in, &other, 20) != NULL);
    }
    free(facets);
    free(points);
    pbw_wrap_free(&w);
}

int main(int argc, char **argv)
{
    static const struct { const char *name; void (*run)(void); } tests[] = {
        { "soups", wrap_soups }, { "elements without area", wrap_degenerate }, { "a cavity", wrap_cavity },
        { "a shell", wrap_shell }, { "what is a shell", tell_shells }, { "the alpha that closes", close_all },
        { "solids of closed models", fill_closed }, { "solids of open models", fill_open },
        { "solids: the time is over", fill_late }, { "solids: failures", fail_solids },
        { "alpha by place", wrap_by_place }, { "nearest elements", find_elements }, { "vertices inside", fill },
        { "refusals", refuse }, { "wrong arguments", refuse_wrong }, { "threads", run_threads },
        { "memory and cancelling", fail_everywhere }, { "memory and cancelling on eight threads", fail_on_threads },
        { "questions while it numbers", ask_often },
        { "faults are seen", see_faults }
    };
    size_t i;
    test_start(argc, argv, 40);
    for (i = 0; i < sizeof tests / sizeof *tests; i++) {
        if (test_begin("%s", tests[i].name)) {
            tests[i].run();
            test_end();
        }
    }
    return test_finish();
}
