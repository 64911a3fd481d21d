/* steps.h: what steps.c and shares.c have in common: points along a Hilbert curve, the triangulation of those that
   are in, the walk to a point and its cavity, and pictures side by side in one SVG file. */
#ifndef STEPS_H
#define STEPS_H
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COUNT = 1024, CELL = 16, CELLS = COUNT / CELL, NOBODY = 0, SIZE = 400, GAP = 32 };
#define DRAW(...) (void)(svg != NULL && fprintf(svg, __VA_ARGS__))

static double points[COUNT][2];                     /* in the order of the curve */
static int inserted[COUNT];                         /* 0: not yet; the later, the higher */
static int owner[CELLS];                            /* the thread that has the cell */
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
         GAP + (SIZE + GAP) * number, 2 * GAP, title);
    for (pbw_index t = 0; t < mesh.simplex_count; t++) {
        const pbw_index *c = mesh.simplices + 3 * t;
        int who = owner[c[0] / CELL];
        triangle(t, colours[owner[c[1] / CELL] == who && owner[c[2] / CELL] == who ? who : NOBODY], 0.35);
    }
}

/* Three pictures side by side, in the file that the program's argument names, if any. */
static void begin_pictures(int argc, char **argv)
{
    svg = argc > 1 ? fopen(argv[1], "w") : NULL;
    DRAW("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' font-family='sans-serif' font-size='15' "
         "stroke='#98a2b3' stroke-linejoin='round'>\n<rect width='100%%' height='100%%' fill='#fff'/>\n<g>\n",
         3 * (SIZE + GAP) + GAP, SIZE + 3 * GAP);
}

/* Returns the program's exit status. */
static int end_pictures(int argc, char **argv)
{
    DRAW("</g>\n</svg>\n");
    if (argc > 1 && (svg == NULL || ferror(svg) || fclose(svg) != 0)) {
        perror(argv[1]);
        return 1;
    }
    pbw_free(&mesh);
    return 0;
}

#endif
