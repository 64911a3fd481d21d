/* steps.c: how points get into a Delaunay triangulation: walk, cavity and star of one; then many at once, by four
   threads that have cells of the plane, which are runs of a Hilbert curve.
   cc -O2 -I. examples/steps.c -o steps -lpthread -lm
   steps steps.svg also draws it, six pictures in one file.  Prints expected/steps.txt. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>

enum { COUNT = 1024, CELL = 16, CELLS = COUNT / CELL, NOBODY = 0, THREADS = 4, SIZE = 400, GAP = 32 };
#define DRAW(...) (void)(svg != NULL && fprintf(svg, __VA_ARGS__))

static double points[COUNT][2];                     /* in the order of the curve */
static int inserted[COUNT], last = 1;               /* 0: not yet; the later, the higher */
static int thread[COUNT], owner[CELLS];             /* who tried to insert it; who has the cell */
static pbw_index walk[2 * COUNT], cavity[2 * COUNT];
static int walked, carved;
static pbw_mesh mesh;
static FILE *svg;                                   /* NULL: no pictures */
static const char *const colours[] = { "#fff", "#0072b2", "#e69f00", "#009e73", "#cc79a7" };

/* A point in each of 32 x 32 squares, as the curve comes through; those of the outer squares are at the border. */
static void scatter(void)
{
    unsigned random = 1;
    for (int i = 0; i < COUNT; i++) {
        int x[2] = { 0, 0 };
        for (int side = 1, time = i; side < 32; side *= 2, time /= 4) {      /* from quarters to the square of four */
            int right = time % 4 / 2, upper = time % 2 ^ right, old = x[0];
            x[0] = upper ? x[0] + right * side : right ? 2 * side - 1 - x[1] : x[1];
            x[1] = upper ? x[1] + side : right ? side - 1 - old : old;
        }
        for (int k = 0; k < 2; k++) {
            double place = x[k] + 0.1 + 0.8 * (random = random * 1664525u + 1013904223u) / 4294967296.0;
            points[i][k] = x[k] == 0 ? 0 : x[k] == 31 ? SIZE : place * SIZE / 32;
        }
    }
}

static const double *corner(pbw_index t, int i) { return points[mesh.simplices[3 * t + (pbw_index)i % 3]]; }

static void triangulate(void)                       /* what is inserted; the rest lies on the first, as duplicates */
{
    static double copy[COUNT][2];
    for (int i = 0; i < COUNT; i++) {
        memcpy(copy[i], points[inserted[i] ? i : 0], sizeof copy[i]);
    }
    pbw_free(&mesh);
    if (pbw_triangulate(2, copy[0], NULL, COUNT, NULL, &mesh) != PBW_OK) {
        exit(1);
    }
}

static void begin_with(int step)                    /* one in that many, the corners of the square among them */
{
    for (int i = 0; i < COUNT; i++) {
        inserted[i] = i % step == i / 256 * 5 % step;
    }
    triangulate();
}

/* A walk across edges that have q on their far side; then the triangles with q in their circle, which hang together,
   from where it ended.  No point is outside of all. */
static void locate(const double *q)
{
    walk[0] = mesh.incident[0];
    walked = carved = 1;
    for (int i = 0; i < 3; i++) {
        pbw_index t = walk[walked - 1];
        if (pbw_orient2(corner(t, i + 1), corner(t, i + 2), q) < 0) {
            walk[walked++] = mesh.neighbors[3 * t + (pbw_index)i];
            i = -1;
        }
    }
    cavity[0] = walk[walked - 1];
    for (int at = 0, k; at < 3 * carved; at++) {
        pbw_index t = mesh.neighbors[3 * cavity[at / 3] + (pbw_index)(at % 3)];
        for (k = 0; k < carved && cavity[k] != t; k++) {
        }
        if (k == carved && t != PBW_NONE && pbw_incircle(corner(t, 0), corner(t, 1), corner(t, 2), q) > 0) {
            cavity[carved++] = t;
        }
    }
}

static void triangle(pbw_index t, const char *fill, double opacity)
{
    const double *a = corner(t, 0), *b = corner(t, 1), *c = corner(t, 2);
    DRAW("<path fill='%s' fill-opacity='%.2f' d='M%.1f %.1fL%.1f %.1f %.1f %.1fz'/>\n", fill, opacity, a[0], a[1],
         b[0], b[1], c[0], c[1]);
}

static void circle(const double *p, double radius, const char *fill, const char *stroke)
{
    DRAW("<circle cx='%.1f' cy='%.1f' r='%.1f' fill='%s' stroke='%s'/>\n", p[0], p[1], radius, fill, stroke);
}

/* Begins one.  A triangle with all corners in cells of a thread has its colour: only that one may delete it. */
static void picture(const char *title)
{
    int number = title[0] - '1';
    DRAW("</g>\n<g transform='translate(%d %d)'>\n<text y='-12' stroke='none'>%s</text>\n",
         GAP + (SIZE + GAP) * (number % 3), 2 * GAP + (SIZE + 2 * GAP) * (number / 3), title);
    for (pbw_index t = 0; t < mesh.simplex_count; t++) {
        const pbw_index *c = mesh.simplices + 3 * t;
        int who = owner[c[0] / CELL];
        triangle(t, colours[owner[c[1] / CELL] == who && owner[c[2] / CELL] == who ? who : NOBODY], 0.35);
    }
}

static void one_point(int which)
{
    const double *q = points[which];
    int star = 0;
    locate(q);
    picture("1  Walk: across edges that have the point beyond");
    for (int i = 0; i < walked; i++) {
        triangle(walk[i], "#0072b2", 0.15 + 0.5 * i / walked);
    }
    circle(q, 5, "#d55e00", "#fff");
    picture("2  Cavity: triangles whose circles hold the point");
    for (int i = 0; i < carved; i++) {
        const double *a = corner(cavity[i], 0), *b = corner(cavity[i], 1), *c = corner(cavity[i], 2);
        double u = b[0] - a[0], v = b[1] - a[1], x = c[0] - a[0], y = c[1] - a[1], area = 2 * (u * y - v * x);
        double r = u * u + v * v, s = x * x + y * y, dx = (y * r - v * s) / area, dy = (u * s - x * r) / area;
        triangle(cavity[i], "#e69f00", 0.6);
        circle((double[2]) { a[0] + dx, a[1] + dy }, sqrt(dx * dx + dy * dy), "none", "#d55e00");
    }
    circle(q, 5, "#d55e00", "#fff");
    inserted[which] = 1;
    triangulate();
    picture("3  Star: the cavity filled from the point");
    for (pbw_index i = 0; i < 3 * mesh.simplex_count; i++) {
        if (mesh.simplices[i] == (pbw_index)which) {
            triangle(i / 3, "#009e73", 0.4);
            star++;
        }
    }
    circle(q, 5, "#d55e00", "#fff");
    printf("one point: a walk through %d triangles, a cavity of %d, a star of %d\n", walked, carved, star);
}

/* A thread inserts a point if all corners of the cavity are in its cells; it takes those that are nobody's.  Cavities
   of two threads then have no corner in common, and each stays what it is whatever the other does. */
static int insert(int i, int me)
{
    int mine = 1;
    locate(points[i]);
    for (int k = 0; k < 3 * carved; k++) {
        int *cell = owner + mesh.simplices[3 * cavity[k / 3] + (pbw_index)k % 3] / CELL;
        *cell = *cell == NOBODY ? me : *cell;
        mine &= *cell == me;
    }
    thread[i] = me;
    inserted[i] = mine ? ++last : 0;
    return mine;
}

/* Each thread goes through its share of what is left, all at the same pace.  Returns how many points they leave. */
static int insert_round(int number, int threads)
{
    int left[COUNT], count = 0, done = 0;
    for (int i = 0; i < COUNT; i++) {
        left[count] = i;
        count += !inserted[i];
    }
    for (int step = 0; step * threads < count; step++) {
        int before = last;
        memset(owner, NOBODY, sizeof owner);
        for (int me = 1; me <= threads; me++) {
            int at = count * (me - 1) / threads + step;
            done += at < count * me / threads && insert(left[at], me);
        }
        if (number == 1 && (step == count / threads * 3 / 10 || step == count / threads * 8 / 10)) {
            picture(step < count / threads / 2 ? "4  Four threads: a point takes the cells that it needs"
                                               : "5  Further on: black points met another thread's");
            for (int i = 0; i < count; i++) {
                int v = left[i];
                if (inserted[v] > before) {
                    locate(points[v]);
                    for (int k = 0; k < carved; k++) {
                        triangle(cavity[k], colours[thread[v]], 0.6);
                    }
                    circle(points[v], 5, colours[thread[v]], "#fff");
                } else if (!inserted[v]) {
                    circle(points[v], thread[v] == NOBODY ? 2.2 : 4, thread[v] == NOBODY ? "#fff" : "#101828",
                           "#101828");
                }
            }
        }
        triangulate();
    }
    printf("round %d: %d points by %d thread%s, %d left\n", number, done, threads, threads > 1 ? "s" : "",
           count - done);
    return count - done;
}

int main(int argc, char **argv)
{
    svg = argc > 1 ? fopen(argv[1], "w") : NULL;
    DRAW("<svg xmlns='http://www.w3.org/2000/svg' width='%d' height='%d' font-family='sans-serif' font-size='15' "
         "stroke='#98a2b3' stroke-linejoin='round'>\n<rect width='100%%' height='100%%' fill='#fff'/>\n<g>\n",
         3 * (SIZE + GAP) + GAP, 2 * SIZE + 5 * GAP);
    scatter();
    begin_with(16);
    one_point(540);
    begin_with(4);
    for (int round = 1, left = COUNT; left > 0; round++) {
        left = insert_round(round, left > 8 * THREADS ? THREADS : 1);
    }
    memset(owner, NOBODY, sizeof owner);
    picture("6  Done: which thread made each triangle");
    for (pbw_index t = 0; t < mesh.simplex_count; t++) {
        const pbw_index *c = mesh.simplices + 3 * t;
        pbw_index v = inserted[c[1]] > inserted[c[0]] ? c[1] : c[0];
        triangle(t, colours[thread[inserted[c[2]] > inserted[v] ? c[2] : v]], 0.5);
    }
    DRAW("</g>\n</svg>\n");
    if (argc > 1 && (svg == NULL || ferror(svg) || fclose(svg) != 0)) {
        perror(argv[1]);
        return 1;
    }
    pbw_free(&mesh);
    return 0;
}
