/* parts.h: closed surfaces whose volume is known, for tests and benches of solids: prisms, turned
   parts, boxes in boxes.  Out: a part, in static or allocated storage; each maker returns the
   volume.  Triangles are turned outward. */
#ifndef PARTS_H
#define PARTS_H
#include "pbw.h"
#include <math.h>
#include <string.h>

#if defined(__clang__)                      /* the same coordinates where a compiler would fuse */
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif

#define PARTS_PI 3.14159265358979323846

enum { PARTS_POINTS = 6000 };

typedef struct part {
    double x[PARTS_POINTS][3];
    pbw_index t[2 * PARTS_POINTS][3];
    size_t points, triangles;
} part;

static size_t part_point(part *m, double x, double y, double z)
{
    m->x[m->points][0] = x;
    m->x[m->points][1] = y;
    m->x[m->points][2] = z;
    return m->points++;
}

static void part_triangle(part *m, size_t a, size_t b, size_t c)
{
    m->t[m->triangles][0] = (pbw_index)a;
    m->t[m->triangles][1] = (pbw_index)b;
    m->t[m->triangles++][2] = (pbw_index)c;
}

/* Turns the part about all axes, so that its planes and edges are uneven. */
static void part_turn(part *m)
{
    size_t i;
    int k;
    for (i = 0; i < m->points; i++) {
        for (k = 0; k < 3; k++) {
            double *a = m->x[i] + k, *b = m->x[i] + (k + 1) % 3;
            const double was = *a;
            *a = 0.8 * was - 0.6 * *b;
            *b = 0.6 * was + 0.8 * *b;
        }
    }
}

/* A prism over the ring between two polygons of n corners. */
static void part_ring(part *m, size_t n, const double (*outer)[2], const double (*inner)[2], double height)
{
    const size_t o = m->points, i = o + n, up = 2 * n;
    size_t k;
    for (k = 0; k < 4 * n; k++) {
        const double *p = k / n % 2 == 0 ? outer[k % n] : inner[k % n];
        (void)part_point(m, p[0], p[1], k < 2 * n ? 0 : height);
    }
    for (k = 0; k < n; k++) {
        const size_t l = (k + 1) % n;
        part_triangle(m, o + k, i + k, o + l);
        part_triangle(m, o + l, i + k, i + l);
        part_triangle(m, up + o + k, up + o + l, up + i + k);
        part_triangle(m, up + o + l, up + i + l, up + i + k);
        part_triangle(m, o + k, o + l, up + o + l);
        part_triangle(m, o + k, up + o + l, up + o + k);
        part_triangle(m, i + k, up + i + k, up + i + l);
        part_triangle(m, i + k, up + i + l, i + l);
    }
}

/* A prism over a polygon that (cx, cy) sees all of.  Returns its volume. */
static double part_prism(part *m, size_t n, const double (*p)[2], const double centre[2], double height)
{
    const size_t first = m->points;
    double area = 0;
    size_t k;
    for (k = 0; k < 2 * n; k++) {
        (void)part_point(m, p[k % n][0], p[k % n][1], k < n ? 0 : height);
    }
    (void)part_point(m, centre[0], centre[1], 0);
    (void)part_point(m, centre[0], centre[1], height);
    for (k = 0; k < n; k++) {
        const size_t l = (k + 1) % n, a = first + k, b = first + l;
        part_triangle(m, a, first + 2 * n, b);
        part_triangle(m, n + a, n + b, first + 2 * n + 1);
        part_triangle(m, a, b, n + b);
        part_triangle(m, a, n + b, n + a);
        area += 0.5 * (p[k][0] * p[l][1] - p[k][1] * p[l][0]);
    }
    return area * height;
}

/* What a line of n points (r, z) sweeps around the z axis, in `sides` steps; points with r = 0 are one point.
   closed: the line ends where it begins.  z rises outside.  Returns the volume of the polyhedron. */
static double part_turned(part *m, size_t n, const double (*line)[2], size_t sides, int closed)
{
    const double wedge = sin(2 * PARTS_PI / (double)sides) * (double)sides / 2;
    size_t at[64], i, k, steps = closed ? n : n - 1;
    double volume = 0;
    for (i = 0; i < n; i++) {
        at[i] = m->points;
        for (k = 0; k < (line[i][0] > 0 ? sides : 1); k++) {
            const double a = 2 * PARTS_PI * (double)k / (double)sides;
            (void)part_point(m, line[i][0] * cos(a), line[i][0] * sin(a), line[i][1]);
        }
    }
    for (i = 0; i < steps; i++) {
        const size_t j = (i + 1) % n;
        const double r = line[i][0], s = line[j][0];
        for (k = 0; k < sides; k++) {
            const size_t l = (k + 1) % sides;
            if (s > 0) {
                part_triangle(m, at[i] + (r > 0 ? k : 0), at[j] + l, at[j] + k);
            }
            if (r > 0) {
                part_triangle(m, at[i] + k, at[i] + l, at[j] + (s > 0 ? l : 0));
            }
        }
        volume += (line[j][1] - line[i][1]) * (r * r + r * s + s * s) / 3 * wedge;
    }
    return volume;
}

/* A box; inside out if `hole`. */
static double part_box(part *m, const double low[3], const double high[3], int hole)
{
    static const int face[6][4] = { { 0, 2, 3, 1 }, { 4, 5, 7, 6 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 }, { 0, 4, 6, 2 },
                                    { 1, 3, 7, 5 } };
    const size_t o = m->points;
    int i;
    for (i = 0; i < 8; i++) {
        (void)part_point(m, i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]);
    }
    for (i = 0; i < 6; i++) {
        const size_t a = o + (size_t)face[i][0], b = o + (size_t)face[i][1], c = o + (size_t)face[i][2];
        const size_t d = o + (size_t)face[i][3];
        part_triangle(m, a, hole ? c : b, hole ? b : c);
        part_triangle(m, a, hole ? d : c, hole ? c : d);
    }
    return (hole ? -1 : 1) * (high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2]);
}

/* ---- the parts ---- */

/* A unit cube with a round hole of radius 1/4. */
static double part_hole(part *m)
{
    double outer[32][2], inner[32][2];
    size_t k;
    for (k = 0; k < 32; k++) {
        const double a = 2 * PARTS_PI * (double)k / 32 - 0.75 * PARTS_PI, along = (double)(k % 8) / 8;
        inner[k][0] = 0.5 + 0.25 * cos(a);
        inner[k][1] = 0.5 + 0.25 * sin(a);
        outer[k][0] = k < 8 ? along : k < 16 ? 1 : k < 24 ? 1 - along : 0;
        outer[k][1] = k < 8 ? 0 : k < 16 ? along : k < 24 ? 1 : 1 - along;
    }
    part_ring(m, 32, (const double (*)[2])outer, (const double (*)[2])inner, 1);
    return 1 - sin(2 * PARTS_PI / 32);
}

static double part_l(part *m)
{
    static const double p[6][2] = { { 0, 0 }, { 2, 0 }, { 2, 1 }, { 1, 1 }, { 1, 2 }, { 0, 2 } };
    static const double c[2] = { 0.5, 0.5 };
    return part_prism(m, 6, p, c, 1);
}

/* A wedge of 20 degrees. */
static double part_wedge(part *m)
{
    double p[3][2] = { { 0, 0 }, { 1, 0 }, { 1, 0 } };
    static const double c[2] = { 0.7, 0.1 };
    p[2][1] = tan(20 * PARTS_PI / 180);
    return part_prism(m, 3, (const double (*)[2])p, c, 1);
}

/* A pointed tetrahedron: three edges of some 40 degrees. */
static double part_spike(part *m)
{
    const size_t a = part_point(m, 0, 0, 0), b = part_point(m, 1, 0, 0), c = part_point(m, 0.3, 0.9, 0);
    const size_t d = part_point(m, 0.4, 0.3, 1.2);
    part_triangle(m, a, c, b);
    part_triangle(m, a, b, d);
    part_triangle(m, b, c, d);
    part_triangle(m, c, a, d);
    return 0.9 * 1.2 / 6;
}

static double part_shaft(part *m)
{
    static const double line[6][2] = { { 0, 0 }, { 0.5, 0 }, { 0.5, 0.8 }, { 0.3, 0.8 }, { 0.3, 2 }, { 0, 2 } };
    return part_turned(m, 6, line, 48, 0);
}

/* Twelve teeth. */
static double part_gear(part *m)
{
    double p[48][2];
    static const double c[2] = { 0, 0 };
    size_t k;
    for (k = 0; k < 48; k++) {
        const double a = 2 * PARTS_PI * ((double)(k / 4) + 0.25 * (double)(k % 4)
                                         + (k % 4 == 1 ? 0.04 : k % 4 == 2 ? -0.04 : 0)) / 12;
        const double r = k % 4 == 1 || k % 4 == 2 ? 1 : 0.75;
        p[k][0] = r * cos(a);
        p[k][1] = r * sin(a);
    }
    return part_prism(m, 48, (const double (*)[2])p, c, 0.4);
}

/* A fan's foot: a round side that runs into planes, edges from 60 to 120 degrees. */
static double part_fan(part *m)
{
    double p[19][2];
    static const double c[2] = { 0.6, 0.35 };
    size_t k;
    p[0][0] = 0, p[0][1] = 0;
    p[1][0] = 1.2, p[1][1] = 0;
    p[2][0] = 1, p[2][1] = 0.35;
    for (k = 3; k < 19; k++) {
        const double a = PARTS_PI / 2 * (double)(k - 3) / 15;
        p[k][0] = 0.3 + 0.7 * cos(a);
        p[k][1] = 0.35 + 0.5 * sin(a);
    }
    return part_prism(m, 19, (const double (*)[2])p, c, 0.8);
}

/* A closed box whose walls are 1.8 % of its diagonal thick. */
static double part_shell(part *m)
{
    static const double low[3] = { 0, 0, 0 }, high[3] = { 1, 0.8, 0.6 };
    const double thick = 0.018 * sqrt(2.0);
    double in[2][3];
    int k;
    for (k = 0; k < 3; k++) {
        in[0][k] = low[k] + thick;
        in[1][k] = high[k] - thick;
    }
    return part_box(m, low, high, 0) + part_box(m, in[0], in[1], 1);
}

/* Five thin ribs from a hub. */
static double part_ribs(part *m)
{
    double p[15][2];
    static const double c[2] = { 0, 0 };
    const double half = 0.02;
    size_t k;
    for (k = 0; k < 5; k++) {
        const double a = 2 * PARTS_PI * ((double)k + 0.1) / 5, b = a + PARTS_PI / 5;
        const double r = 1.6 * half / sin(PARTS_PI / 5);
        p[3 * k][0] = cos(a) + half * sin(a), p[3 * k][1] = sin(a) - half * cos(a);
        p[3 * k + 1][0] = cos(a) - half * sin(a), p[3 * k + 1][1] = sin(a) + half * cos(a);
        p[3 * k + 2][0] = r * cos(b), p[3 * k + 2][1] = r * sin(b);
    }
    return part_prism(m, 15, (const double (*)[2])p, c, 0.7);
}

/* Two thin tubes, one in the other, apart. */
static double part_tubes(part *m)
{
    static const double outer[4][2] = { { 0.46, 0 }, { 0.5, 0 }, { 0.5, 1 }, { 0.46, 1 } };
    static const double inner[4][2] = { { 0.36, 0 }, { 0.4, 0 }, { 0.4, 1 }, { 0.36, 1 } };
    return part_turned(m, 4, outer, 48, 1) + part_turned(m, 4, inner, 48, 1);
}

/* A ball that is hollow: two shells. */
static double part_ball(part *m)
{
    double line[2][17][2];
    size_t k;
    for (k = 0; k < 17; k++) {
        const double a = PARTS_PI * (double)k / 16;
        line[0][k][0] = k % 16 ? sin(a) : 0, line[0][k][1] = -cos(a);
        line[1][16 - k][0] = k % 16 ? 0.6 * sin(a) : 0, line[1][16 - k][1] = -0.6 * cos(a);
    }
    return part_turned(m, 17, (const double (*)[2])line[0], 32, 0)
         + part_turned(m, 17, (const double (*)[2])line[1], 32, 0);
}

static double part_plate(part *m)
{
    static const double low[3] = { 0, 0, 0 }, high[3] = { 1, 1, 0.02 };
    return part_box(m, low, high, 0);
}

/* A blade, from 0.015 to 0.05 thick. */
static double part_blade(part *m)
{
    static const double p[4][2] = { { 0, 0 }, { 1, 0.01 }, { 1, 0.06 }, { 0, 0.015 } }, c[2] = { 0.6, 0.02 };
    return part_prism(m, 4, p, c, 0.6);
}

/* A cup of 24 flat sides, slanted, its walls 0.03 thick. */
static double part_cup(part *m)
{
    static const double line[6][2] = { { 0, 0 }, { 0.35, 0 }, { 0.5, 0.6 }, { 0.469, 0.6 }, { 0.327, 0.03 },
                                       { 0, 0.03 } };
    return part_turned(m, 6, line, 24, 0);
}

/* A ring of twelve flat walls, 0.04 thick. */
static double part_knob(part *m)
{
    double p[2][12][2];
    size_t k;
    for (k = 0; k < 24; k++) {
        const double a = PARTS_PI * (double)(k % 12) / 6, r = k < 12 ? 0.5 : 0.46;
        p[k / 12][k % 12][0] = r * cos(a);
        p[k / 12][k % 12][1] = r * sin(a);
    }
    part_ring(m, 12, (const double (*)[2])p[0], (const double (*)[2])p[1], 0.4);
    return 0.4 * 6 * sin(PARTS_PI / 6) * (0.25 - 0.46 * 0.46);
}

/* Seven blades from a hub, 0.015 thick at their tips and 0.08 at the hub. */
static double part_fins(part *m)
{
    double p[21][2];
    static const double c[2] = { 0, 0 };
    size_t k;
    for (k = 0; k < 7; k++) {
        const double a = 2 * PARTS_PI * ((double)k + 0.1) / 7, b = a + PARTS_PI / 7;
        p[3 * k][0] = cos(a) + 0.0075 * sin(a), p[3 * k][1] = sin(a) - 0.0075 * cos(a);
        p[3 * k + 1][0] = cos(a) - 0.0075 * sin(a), p[3 * k + 1][1] = sin(a) + 0.0075 * cos(a);
        p[3 * k + 2][0] = 0.1 * cos(b), p[3 * k + 2][1] = 0.1 * sin(b);
    }
    return part_prism(m, 21, (const double (*)[2])p, c, 0.5);
}

typedef struct part_entry { const char *name; double (*make)(part *m); double size; long euler; } part_entry;

/* size: the length of edges that suits it; euler: of its boundary. */
static const part_entry parts[] = {
    { "L", part_l, 0.15, 2 }, { "hole", part_hole, 0.08, 0 }, { "shaft", part_shaft, 0.12, 2 },
    { "gear", part_gear, 0.1, 2 }, { "fan", part_fan, 0.08, 2 }, { "wedge 20", part_wedge, 0.1, 2 },
    { "spike", part_spike, 0.1, 2 }, { "ball", part_ball, 0.15, 4 }, { "plate 1:50", part_plate, 0.05, 2 },
    { "shell", part_shell, 0.06, 4 }, { "ribs", part_ribs, 0.08, 2 }, { "tubes", part_tubes, 0.06, 0 },
    { "blade", part_blade, 0.05, 2 }, { "cup", part_cup, 0.06, 2 }, { "knob", part_knob, 0.06, 0 },
    { "fins", part_fins, 0.05, 2 }
};
enum { PART_L = 0, PART_HOLE = 1, PART_GEAR = 3, PART_WEDGE = 5, PART_SPIKE = 6, PART_BALL = 7,
       PART_COUNT = sizeof parts / sizeof *parts };

/* Makes part number i, turned or not.  Returns its volume. */
static double part_make(size_t i, int turned, part *m)
{
    double volume;
    m->points = m->triangles = 0;
    volume = parts[i].make(m);
    if (turned) {
        part_turn(m);
    }
    return volume;
}

#if defined(__clang__)
#pragma STDC FP_CONTRACT DEFAULT
#elif defined(__GNUC__)
#pragma GCC pop_options
#endif
#endif
