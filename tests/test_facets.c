/* test_facets.c: examples/lib/pbw_io.h reads .poly and .smesh: what their sections say; facets with holes, lines and
   points, whose triangles must have the right area and number and keep every line; what is refused. */
#include "pbw_io.h"
#include "meter.h"
#include "test.h"
#include <math.h>

static pbwio_status read_text(const char *name, const char *text, pbwio_cloud *c, pbwio_error *error)
{
    memset(error, 0, sizeof *error);
    return pbwio_read_memory(name, text, strlen(text), NULL, c, error);
}

static double area_of(const pbwio_cloud *c)
{
    double area = 0, n[3];
    size_t i;
    int k;
    for (i = 0; i < c->triangle_count; i++) {
        const double *p = c->points + 3 * (size_t)c->triangles[3 * i];
        const double *q = c->points + 3 * (size_t)c->triangles[3 * i + 1];
        const double *r = c->points + 3 * (size_t)c->triangles[3 * i + 2];
        for (k = 0; k < 3; k++) {
            const int u = (k + 1) % 3, v = (k + 2) % 3;
            n[k] = (q[u] - p[u]) * (r[v] - p[v]) - (q[v] - p[v]) * (r[u] - p[u]);
        }
        area += sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
    }
    return area;
}

static double length_of(const pbwio_cloud *c)
{
    double length = 0;
    size_t i;
    for (i = 0; i < c->segment_count; i++) {
        const double *p = c->points + 3 * (size_t)c->segments[2 * i];
        const double *q = c->points + 3 * (size_t)c->segments[2 * i + 1];
        length += sqrt(pow(q[0] - p[0], 2) + pow(q[1] - p[1], 2) + pow(q[2] - p[2], 2));
    }
    return length;
}

/* ---- what the sections say ---- */

static void test_sections(void)
{
    static const char *const facets[] = {
        "6 1\n1 0 1 # bottom\n4 %d %d %d %d\n1 0 2\n4 %d %d\n%d %d\n1 0 3\n4 %d %d %d %d\n1\n4 %d %d %d %d\n"
        "1 0 -4\n4 %d %d %d %d\n1 0 3\n4 %d %d %d %d\n",
        "6 1\n4 %d %d %d %d 1\n4 %d %d\n%d %d 2\n4 %d %d %d %d 3\n\n4 %d %d %d %d\n4 %d %d %d %d -4\n"
        "4 %d %d %d %d 3\n"
    };
    static const int ids[24] = { 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7 };
    int base, form;
    for (form = 0; form < 4; form++) {
        char text[2000];
        const char *at;
        size_t i, used = 0;
        pbwio_cloud c;
        pbwio_error error;
        base = form % 2;
        used = (size_t)sprintf(text, "# a cube\n8 3 1 1\n");
        for (i = 0; i < 8; i++) {
            used += (size_t)sprintf(text + used, "%d %d %d %d .5 %d\n", (int)i + base, i % 4 == 1 || i % 4 == 2,
                                    i % 4 > 1, i > 3, i == 0 ? 7 : 0);
        }
        for (at = facets[form / 2], i = 0; *at != 0; at++) {
            if (*at == '%') {
                used += (size_t)sprintf(text + used, "%d", ids[i++] + base);
                at++;
            } else {
                text[used++] = *at;
            }
        }
        sprintf(text + used, "1\n1 .5 .5 .75\n# regions\n2\n1 .5 .5 .25 -10 .01\n2 .5 .25 .25 3\n");
        if (CHECK(read_text(form < 2 ? "a.poly" : "a.smesh", text, &c, &error) == PBWIO_OK)) {
            CHECK(c.dim == 3 && c.count == 8 && c.base == base && c.column_count == 1 && c.dropped[0] == 0);
            CHECK(c.triangle_count == 12 && c.segment_count == 0 && fabs(area_of(&c) - 6) < 1e-12);
            CHECK(c.point_groups != NULL && c.groups[c.point_groups[0]].tag == 7 && c.point_groups[1] == PBW_NONE);
            CHECK(c.triangle_groups != NULL && c.groups[c.triangle_groups[0]].tag == 1
                  && c.groups[c.triangle_groups[2]].tag == 2 && c.triangle_groups[4] == c.triangle_groups[10]
                  && c.triangle_groups[6] == PBW_NONE && c.groups[c.triangle_groups[8]].tag == -4);
            CHECK(c.seed_count == 3 && c.seeds[0].group == PBW_NONE && c.seeds[0].place[2] > 0.7);
            CHECK(c.seed_count == 3 && c.groups[c.seeds[1].group].tag == -10 && c.groups[c.seeds[1].group].dim == 3
                  && fabs(c.seeds[1].bound - 0.01) < 1e-15 && c.seeds[2].bound <= 0
                  && c.groups[c.seeds[2].group].tag == 3);
            pbwio_free(&c);
        } else {
            test_say("%s", error.text);
        }
    }
}

static void test_plane_domain(void)
{
    pbwio_cloud c;
    pbwio_error error;
    CHECK(read_text("a.poly", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n3 1\n1 1 2 5\n2 2 3 5\n3 3 1 6\n1\n1 .1 .1\n1\n"
                    "1 .2 .2 8 .5\n", &c, &error) == PBWIO_OK);
    CHECK(c.dim == 2 && c.segment_count == 3 && c.groups[c.segment_groups[2]].tag == 6 && c.seed_count == 2
          && c.groups[c.seeds[1].group].dim == 2 && c.seeds[1].bound > 0.4);
    pbwio_free(&c);
}

/* ---- what is refused ---- */

static void test_refused(void)
{
    static const struct { const char *text, *words; } cases[] = {
        { "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n1\n1\n3 1 2 5\n", ":8: a facet has point 5, there are 1 to 4" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n1\n1\n3 1 2 x\n", "\"x\" is not a corner" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n2\n1\n3 1 2 3\n", "the file ends where a facet should be" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n1\n2\n3 1 2 3\n", "the file ends where an outline should be" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n1\n1\n4 1 3 2 4\n", "edges of a facet cross" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n1\n1 1\n4 1 2 3 4\n1 .5 0 0\n", "hole lies on an edge" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n1\n1 1\n4 1 2 3 4\n1 1 0 0\n", "points at one place" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 2 0 0\n4 3 0 0\n1\n1\n4 1 2 3 4\n", "corners of a facet are on one line" },
        { "4 3\n1 1 0 0\n2 1 0 1\n3 1 0 2\n4 1 0 3\n1\n1\n4 1 2 3 4\n", "corners of a facet are on one line" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n1\n1\n3 1 2 3\n0\n1\n1 0 0 0 1.5\n", "a whole number is needed" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n1\n0\n", "a facet of 0 corners" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n1\n2\n0\n3 1 2 3\n", "an outline without corners" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n1\n1\n-3 1 2 3\n", "is not a number of corners" },
        { "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n", "the file ends where the number of facets should be" },
        { "0 3\n1\n1\n3 1 2 3\n", "the points of this file are in the .node file beside it" },
        { "2 2\n1 0 0\n2 1 1\n1\n1 1 3\n", "an element has a point that is not there" }
    };
    size_t i;
    for (i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        pbwio_cloud c;
        pbwio_error error;
        const pbwio_status status = read_text("a.poly", cases[i].text, &c, &error);
        if (!CHECK(status != PBWIO_OK && strstr(error.text, cases[i].words) != NULL)) {
            test_say("case %zu: %s", i, error.text);
        }
        pbwio_free(&c);
    }
}

static void test_bent(void)
{
    pbwio_cloud c;
    pbwio_error error;
    CHECK(read_text("a.poly", "5 3\n0 0 0 0\n1 2 0 0\n2 2 2 0.5\n3 0 2 0\n4 9 9 9\n2\n1\n4 0 1 2 3\n1\n3 0 1 4\n", &c,
                    &error) == PBWIO_OK);
    CHECK(c.triangle_count == 3 && strstr(c.dropped, "the flatness of 1 facet: ") != NULL);
    pbwio_free(&c);
}

/* ---- random facets, brute force beside ---- */

enum { SIDE = 12, MOST_POINTS = 80, MOST_LINES = 40 };

typedef struct drawing {
    int x[MOST_POINTS][2], points, lines[MOST_LINES][2], line_count;
} drawing;

static uint64_t state;

static int below(int n)
{
    state += 0x9e3779b97f4a7c15u;
    return (int)(pbw_mix(state) % (uint64_t)n);
}

static int turn(const int *a, const int *b, const int *c)
{
    const int t = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    return (t > 0) - (t < 0);
}

/* Whether two lines cross, or lie on each other; an end on the other line is fine. */
static int lines_cross(const drawing *d, const int *p, const int *q)
{
    const int *a = d->x[p[0]], *b = d->x[p[1]], *c = d->x[q[0]], *e = d->x[q[1]];
    const int s = turn(a, b, c), t = turn(a, b, e), u = turn(c, e, a), v = turn(c, e, b);
    if (s == 0 && t == 0) {
        const int axis = a[0] == b[0], low = a[axis] < b[axis] ? a[axis] : b[axis], high = a[axis] + b[axis] - low;
        const int from = c[axis] < e[axis] ? c[axis] : e[axis], to = c[axis] + e[axis] - from;
        return from < high && low < to;
    }
    return s * t < 0 && u * v < 0;
}

/* Points of a grid in a square, lines between them that do not cross. */
static void draw(drawing *d)
{
    const int count = 4 + below(MOST_POINTS - 4);
    static const int corner[4][2] = { { 0, 0 }, { SIDE, 0 }, { SIDE, SIDE }, { 0, SIDE } };
    int i, k, tries;
    memset(d, 0, sizeof *d);
    for (i = 0; i < count; i++) {
        const int x = i < 4 ? corner[i][0] : below(SIDE + 1), y = i < 4 ? corner[i][1] : below(SIDE + 1);
        for (k = 0; k < d->points && (d->x[k][0] != x || d->x[k][1] != y); k++) {
        }
        if (k == d->points) {
            d->x[k][0] = x;
            d->x[k][1] = y;
            d->points++;
        }
    }
    for (tries = 0; tries < 60 && d->line_count < MOST_LINES; tries++) {
        int *line = d->lines[d->line_count];
        line[0] = below(d->points);
        line[1] = below(d->points);
        for (k = 0; line[0] != line[1] && k < d->line_count && !lines_cross(d, line, d->lines[k]); k++) {
        }
        d->line_count += line[0] != line[1] && k == d->line_count;
    }
}

/* A square with lines and points in a plane of space: all of them must be there.  Returns what is wrong. */
static const char *try_drawing(const drawing *d)
{
    static const int planes[4][6] = { { 1, 0, 0, 0, 1, 0 }, { 0, 1, 0, 0, 0, 1 }, { 1, 2, 3, 2, -1, 4 },
                                      { -3, 0, 1, 1, 5, -2 } };
    const int *e = planes[below(4)];
    const double n[3] = { e[1] * e[5] - e[2] * e[4], e[2] * e[3] - e[0] * e[5], e[0] * e[4] - e[1] * e[3] };
    const double unit = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    char text[16384];
    size_t used = (size_t)sprintf(text, "%d 3\n", d->points), i;
    double length = 0;
    int k, on_side = 0;
    const char *wrong;
    pbwio_cloud c;
    pbwio_error error;
    for (k = 0; k < d->points; k++) {
        const int *p = d->x[k];
        on_side += p[0] % SIDE == 0 || p[1] % SIDE == 0;
        used += (size_t)sprintf(text + used, "%d %d %d %d\n", k, e[0] * p[0] + e[3] * p[1], e[1] * p[0] + e[4] * p[1],
                                e[2] * p[0] + e[5] * p[1]);
    }
    used += (size_t)sprintf(text + used, "1\n%d\n4 0 1 2 3\n", 1 + d->line_count + d->points);
    for (k = 0; k < d->line_count; k++) {
        const int *p = d->x[d->lines[k][0]], *q = d->x[d->lines[k][1]];
        const int x = q[0] - p[0], y = q[1] - p[1];
        const int at_side = (p[0] == q[0] && p[0] % SIDE == 0) || (p[1] == q[1] && p[1] % SIDE == 0);
        used += (size_t)sprintf(text + used, "2 %d %d\n", d->lines[k][0], d->lines[k][1]);
        length += at_side ? 0 : sqrt(pow(e[0] * x + e[3] * y, 2) + pow(e[1] * x + e[4] * y, 2)
                                     + pow(e[2] * x + e[5] * y, 2));
    }
    for (k = 0; k < d->points; k++) {
        used += (size_t)sprintf(text + used, "1 %d\n", k);
    }
    if (read_text("a.poly", text, &c, &error) != PBWIO_OK) {
        test_say("%s", error.text);
        return "it is refused";
    }
    wrong = fabs(area_of(&c) - SIDE * SIDE * unit) > 1e-9 * SIDE * SIDE * unit ? "the area"
          : c.triangle_count != (size_t)(2 * d->points - 2 - on_side) ? "the number of triangles"
          : fabs(length_of(&c) - length) > 1e-9 * (length + 1) ? "the length of the lines" : NULL;
    for (i = 0; i < c.triangle_count && wrong == NULL; i++) {      /* all turned alike, in the drawing's plane */
        const pbw_index *t = c.triangles + 3 * i, *u = c.triangles;
        wrong = turn(d->x[t[0]], d->x[t[1]], d->x[t[2]]) * turn(d->x[u[0]], d->x[u[1]], d->x[u[2]]) <= 0
              ? "a triangle is turned" : NULL;
    }
    pbwio_free(&c);
    return wrong;
}

static void test_drawings(void)
{
    long i;
    for (i = 0; i < test_count; i++) {
        drawing d;
        const char *wrong;
        state = (test_seed << 32) + (uint64_t)i;
        draw(&d);
        wrong = try_drawing(&d);
        if (!CHECK(wrong == NULL)) {
            test_say("drawing %ld: %s", i, wrong);
        }
    }
}

/* A plate with holes in rows, every third of which is only an outline. */
static size_t write_plate(char *text, int rows, double *area)
{
    size_t used = (size_t)sprintf(text, "%d 3\n", 4 + 8 * rows * rows);
    int i, k, holes = 0;
    used += (size_t)sprintf(text + used, "0 0 0 0\n1 %d 0 0\n2 %d 0 %d\n3 0 0 %d\n", 9 * rows, 9 * rows, 9 * rows,
                            9 * rows);
    for (i = 0; i < rows * rows; i++) {
        static const int ring[8][2] = { { 1, 3 }, { 3, 1 }, { 5, 1 }, { 7, 3 },
                                        { 7, 5 }, { 5, 7 }, { 3, 7 }, { 1, 5 } };
        holes += i % 3 != 0;
        for (k = 0; k < 8; k++) {
            used += (size_t)sprintf(text + used, "%d %d 0 %d\n", 4 + 8 * i + k, 9 * (i % rows) + ring[k][0],
                                    9 * (i / rows) + ring[k][1]);
        }
    }
    used += (size_t)sprintf(text + used, "1\n%d %d\n4 0 1 2 3\n", 1 + rows * rows, holes);
    for (i = 0; i < rows * rows; i++) {
        used += (size_t)sprintf(text + used, "8");
        for (k = 0; k < 8; k++) {
            used += (size_t)sprintf(text + used, " %d", 4 + 8 * i + k);
        }
        used += (size_t)sprintf(text + used, "\n");
    }
    for (i = 0; i < rows * rows; i++) {
        if (i % 3 != 0) {
            used += (size_t)sprintf(text + used, "%d %d.5 0 %d.5\n", i, 9 * (i % rows) + 3, 9 * (i / rows) + 3);
        }
    }
    *area = 81.0 * rows * rows - 28 * holes;
    return used;
}

/* Within the memory that is promised; with each k-th allocation refused nothing is held. */
static void test_plates(void)
{
    int rows;
    for (rows = 1; rows <= 64; rows *= 4) {
        char *text = (char *)malloc((size_t)(400 * rows * rows + 1000));
        double area;
        long k, refused = 1;
        const size_t size = write_plate(text, rows, &area);
        for (k = rows > 4 ? 0 : 1; refused > 0; k++) {
            pbwio_options o;
            pbw_options build;
            pbwio_cloud c;
            pbwio_error error;
            pbwio_status status;
            meter m;
            meter_start(&m, k, 0);
            memset(&o, 0, sizeof o);
            memset(&build, 0, sizeof build);
            build.resize = meter_resize;
            build.resize_user = &m;
            o.build = &build;
            status = pbwio_read_memory("a.poly", text, size, &o, &c, &error);
            refused = m.refused;
            CHECK(status == PBWIO_OK || (status == PBWIO_ERROR_MEMORY && refused > 0));
            if (status == PBWIO_OK) {
                CHECK(fabs(area_of(&c) - area) < 1e-9 * area);
                CHECK_EQUAL(c.segment_count, 8 * ((rows * rows + 2) / 3));
                CHECK(m.peak <= 32 * size + 65536);
            }
            pbwio_free(&c);
            CHECK(m.blocks == 0 && m.faults == 0);
        }
        free(text);
    }
}

int main(int argc, char **argv)
{
    static const struct { const char *name; void (*run)(void); } tests[] = {
        { "sections of .poly and .smesh", test_sections }, { ".poly in the plane", test_plane_domain },
        { "what is refused", test_refused }, { "facets that bend", test_bent },
        { "facets with lines and points", test_drawings }, { "plates with holes", test_plates }
    };
    size_t i;
    test_start(argc, argv, 2000);
    for (i = 0; i < sizeof tests / sizeof tests[0]; i++) {
        if (test_begin("%s", tests[i].name)) {
            tests[i].run();
            test_end();
        }
    }
    return test_finish();
}
