/* steps.c: how points get into a Delaunay triangulation: walk, cavity and star of one; then many at once, by four
   threads that share the plane along a Hilbert curve.
   cc -O2 -I. examples/steps.c -o steps -lpthread -lm
   steps steps.svg also draws it, six pictures in one file.  Prints expected/steps.txt. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>

enum { COUNT = 800, PARTS = 4, SIZE = 400, GAP = 32 };
#define DRAW(...) (void)(svg != NULL && fprintf(svg, __VA_ARGS__))

static double points[COUNT][2];                     /* in the order of the curve */
static int inserted[COUNT], walked, carved;
static pbw_index walk[2 * COUNT], cavity[2 * COUNT];
static pbw_mesh mesh;
static FILE *svg;                                   /* NULL: no pictures */
static const char *const colours[PARTS] = { "#0072b2", "#e69f00", "#009e73", "#cc79a7" };

/* Points in cells, of 1024 x 1024, that the curve passes at nearly regular times. */
static void scatter(void)
{
    unsigned long long state = 1;
    for (int i = 0; i < COUNT; i++) {
        double r[3], *p = points[i], side;
        int time;
        for (int k = 0; k < 3; k++) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            r[k] = (double)(state >> 11) / 9007199254740992.0;
        }
        time = (int)((i + r[0]) * 1048576 / COUNT);
        p[0] = r[1];
        p[1] = r[2];
        for (side = 1; side < 1024; side *= 2, time /= 4) {          /* from quarters to the square of four */
            int right = time % 4 / 2, upper = time % 2 ^ right;
            double x = p[0], y = p[1];
            p[0] = upper ? x + right * side : right ? 2 * side - y : y;
            p[1] = upper ? y + side : right ? side - x : x;
        }
        for (int k = 0; k < 2; k++) {               /* those that come first also fence the square in */
            p[k] *= SIZE / side;
            p[k] = i % 4 != 0 ? p[k] : p[k] < SIZE / 16 ? 0 : p[k] > SIZE - SIZE / 16 ? SIZE : p[k];
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

/* A walk from triangle t across edges that have q on their far side; then the triangles with q in their circle, which
   hang together, from where it ended.  No cavity: q is outside of all. */
static void locate(const double *q, pbw_index t)
{
    walked = carved = 0;
    for (int i = 0; i < 3 && t != PBW_NONE; i++) {
        walk[walked] = t;
        if (pbw_orient2(corner(t, i + 1), corner(t, i + 2), q) < 0) {
            t = mesh.neighbors[3 * t + (pbw_index)i];
            walked++;
            i = -1;
        }
    }
    walked++;
    cavity[0] = t;
    carved = t != PBW_NONE;
    for (int at = 0; at < 3 * carved; at++) {
        int k = 0;
        t = mesh.neighbors[3 * cavity[at / 3] + (pbw_index)(at % 3)];
        while (k < carved && cavity[k] != t) {
            k++;
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

static void picture(int number, const char *title)  /* begins one, with all triangles in it */
{
    DRAW("</g>\n<g transform='translate(%d %d)'>\n<text y='-12' stroke='none'>%s</text>\n",
         GAP + (SIZE + GAP) * (number % 3), 2 * GAP + (SIZE + 2 * GAP) * (number / 3), title);
    for (pbw_index t = 0; t < mesh.simplex_count; t++) {
        triangle(t, "#fff", 1);
    }
}

static void one_point(int which)
{
    const double *q = points[which];
    int star = 0;
    locate(q, mesh.incident[0]);
    picture(0, "1  Walk: across edges that have the point beyond");
    for (int i = 0; i < walked; i++) {
        triangle(walk[i], "#0072b2", 0.15 + 0.5 * i / walked);
    }
    circle(q, 5, "#d55e00", "#fff");
    picture(1, "2  Cavity: triangles whose circles hold the point");
    for (int i = 0; i < carved; i++) {
        const double *a = corner(cavity[i], 0), *b = corner(cavity[i], 1), *c = corner(cavity[i], 2);
        double u = b[0] - a[0], v = b[1] - a[1], x = c[0] - a[0], y = c[1] - a[1], area = 2 * (u * y - v * x);
        double r = u * u + v * v, s = x * x + y * y, from_a[2] = { (y * r - v * s) / area, (u * s - x * r) / area };
        double middle[2] = { a[0] + from_a[0], a[1] + from_a[1] };
        triangle(cavity[i], "#e69f00", 0.6);
        circle(middle, sqrt(from_a[0] * from_a[0] + from_a[1] * from_a[1]), "none",
               "#d55e00");
    }
    circle(q, 5, "#d55e00", "#fff");
    inserted[which] = 1;
    triangulate();
    picture(2, "3  Star: the cavity filled from the point");
    for (pbw_index i = 0; i < 3 * mesh.simplex_count; i++) {
        if (mesh.simplices[i] == (pbw_index)which) {
            triangle(i / 3, "#009e73", 0.4);
            star++;
        }
    }
    circle(q, 5, "#d55e00", "#fff");
    printf("one point: a walk through %d triangles, a cavity of %d, a star of %d\n", walked, carved, star);
}

/* Threads at once, each with a part of the curve.  A triangle is a thread's if its corners are: only that one may
   delete it.  A point goes in if its whole cavity is its thread's; others wait for a round with other borders. */
static void insert_round(int round, int threads, const char *title)
{
    int ready[COUNT] = { 0 }, done = 0, left = 0, shift = (round - 1) * 5 * COUNT / PARTS / 8;
#define OWNER(rank) (((int)(rank) + shift) * threads / COUNT % threads)
    picture(2 + round, title);
    for (pbw_index t = 0; t < mesh.simplex_count; t++) {
        const pbw_index *c = mesh.simplices + 3 * t;
        if (OWNER(c[0]) == OWNER(c[1]) && OWNER(c[0]) == OWNER(c[2])) {
            triangle(t, colours[OWNER(c[0])], 0.3);
        }
    }
    for (int i = 0; i < COUNT; i++) {
        if (!inserted[i]) {
            locate(points[i], 0);
            ready[i] = carved > 0;
            for (int k = 0; k < 3 * carved; k++) {
                ready[i] &= OWNER(mesh.simplices[3 * cavity[k / 3] + (pbw_index)k % 3]) == OWNER(i);
            }
            done += ready[i];
            left += !ready[i];
            circle(points[i], 2.2, ready[i] ? colours[OWNER(i)] : "#fff", ready[i] ? "none" : "#101828");
        }
    }
    for (int i = 0; i < COUNT; i++) {
        inserted[i] |= ready[i];
    }
    triangulate();
    printf("round %d: %d points by %d thread%s, %d left\n", round, done, threads, threads > 1 ? "s" : "", left);
}

static void begin_with(int step)                    /* one in that many */
{
    for (int i = 0; i < COUNT; i++) {
        inserted[i] = i % step == 0;
    }
    triangulate();
}

int main(int argc, char **argv)
{
    svg = argc > 1 ? fopen(argv[1], "w") : NULL;
    DRAW("<svg xmlns='http://www.w3.org/2000/svg' width='%d' height='%d' font-family='sans-serif' font-size='15' "
         "stroke='#98a2b3' stroke-linejoin='round'>\n<rect width='100%%' height='100%%' fill='#fff'/>\n<g>\n",
         3 * (SIZE + GAP) + GAP, 2 * SIZE + 5 * GAP);
    scatter();
    begin_with(16);
    one_point(402);
    begin_with(4);
    insert_round(1, PARTS, "4  Four threads: whose is what, what can go in at once");
    insert_round(2, PARTS, "5  The next round has other borders");
    insert_round(3, 1, "6  What is left, by one thread");
    DRAW("</g>\n</svg>\n");
    if (argc > 1 && (svg == NULL || ferror(svg) || fclose(svg) != 0)) {
        perror(argv[1]);
        return 1;
    }
    pbw_free(&mesh);
    return 0;
}
