/* domains.h: plane domains for tests and benches of pbw_mesh2.h: points and segments that grow, and the makers of a
   table of domains.  Only IEEE operations and our own random numbers are used, so that every machine has the same.

       drawing d;
       memset(&d, 0, sizeof d);
       domains[i].make(&d, 0);                              // 1: the full size
       ... pbw_plane_make(input_of(&d), ...) ...
       drawing_free(&d); */
#ifndef DOMAINS_H
#define DOMAINS_H

#include "inputs.h"
#include "zoo.h"

typedef struct drawing {                   /* points and segments that grow */
    double *points;
    pbw_index *segments;
    size_t point_count, segment_count;
    pbw_plane_input input;
} drawing;

static pbw_index put(drawing *d, double x, double y)
{
    if ((d->point_count & (d->point_count - 1)) == 0) {
        d->points = (double *)zoo_grow(d->points, 4 * (d->point_count + 1) * sizeof(double));
    }
    d->points[2 * d->point_count] = x;
    d->points[2 * d->point_count + 1] = y;
    return (pbw_index)d->point_count++;
}

static void line(drawing *d, pbw_index a, pbw_index b)
{
    if ((d->segment_count & (d->segment_count - 1)) == 0) {
        d->segments = (pbw_index *)zoo_grow(d->segments, 4 * (d->segment_count + 1) * sizeof(pbw_index));
    }
    d->segments[2 * d->segment_count] = a;
    d->segments[2 * d->segment_count++ + 1] = b;
}

static void stroke(drawing *d, double x, double y, double u, double v)
{
    const pbw_index a = put(d, x, y);
    line(d, a, put(d, u, v));
}

/* A closed ring of the last `count` points. */
static void ring(drawing *d, size_t count)
{
    const size_t first = d->point_count - count;
    size_t i;
    for (i = 0; i < count; i++) {
        line(d, (pbw_index)(first + i), (pbw_index)(first + (i + 1) % count));
    }
}

static void rectangle(drawing *d, double x, double y, double u, double v)
{
    put(d, x, y);
    put(d, u, y);
    put(d, u, v);
    put(d, x, v);
    ring(d, 4);
}

static void box(drawing *d, double x, double y, double half, int clockwise)
{
    put(d, x - half, y - half);
    put(d, clockwise ? x - half : x + half, clockwise ? y + half : y - half);
    put(d, x + half, y + half);
    put(d, clockwise ? x + half : x - half, clockwise ? y - half : y + half);
    ring(d, 4);
}

static const pbw_plane_input *input_of(drawing *d)
{
    d->input.points = d->points;
    d->input.point_count = d->point_count;
    d->input.segments = d->segments;
    d->input.segment_count = d->segment_count;
    return &d->input;
}

static void drawing_free(drawing *d)
{
    free(d->points);
    free(d->segments);
    memset(d, 0, sizeof *d);
}

/* A rough closed coast of n points about x, y. */
static void coast(drawing *d, double x, double y, double radius, int n, uint64_t *state)
{
    double phase[12];
    int i, k;
    for (k = 0; k < 12; k++) {
        phase[k] = input_uniform(state);
    }
    for (i = 0; i < n; i++) {
        double c, s, r = 1, w = 0.3;
        for (k = 0; k < 12; k++, w *= 0.6) {
            input_turn((double)i / n * (1 << k) + phase[k], &c, &s);
            r += 0.5 * w * c;
        }
        r *= radius * (1 + 0.004 * (input_uniform(state) - 0.5));
        input_turn((double)i / n, &c, &s);
        put(d, x + r * c, y + r * s);
    }
    ring(d, (size_t)n);
}

static void plate(drawing *d)
{
    int i, k;
    box(d, 5, 5, 5.5, 0);
    for (k = 0; k < 20; k++) {
        for (i = 0; i < 200; i++) {
            double c, s;
            input_turn(i / 200.0, &c, &s);
            put(d, k % 5 * 2 + 1 + 0.5 * c, k / 5 * 2.4 + 1.2 + 0.5 * s);
        }
        ring(d, 200);
    }
}

/* ---- the domains of the table, the full ones of some 10,000 to 100,000 segments where they have a size */

static void draw_coasts(drawing *d, int full)
{
    const int k = full ? 10 : 2, n = full ? 1000 : 200;
    uint64_t state = 1;
    int i;
    for (i = 0; i < k * k; i++) {
        coast(d, i % k, i / k, 0.3, n, &state);
    }
}

static void draw_sea(drawing *d, int full)
{
    const int k = full ? 10 : 2;
    draw_coasts(d, full);
    rectangle(d, -1, -1, k, k);
}

/* Delaunay edges of points that were 4 times as high. */
static void draw_sheared(drawing *d, int full)
{
    const size_t n = full ? 20000 : 300;
    uint64_t state = 3;
    pbw_mesh mesh;
    size_t i;
    for (i = 0; i < n; i++) {
        put(d, input_uniform(&state), 4 * input_uniform(&state));
    }
    (void)pbw_triangulate(2, d->points, NULL, n, NULL, &mesh);
    for (i = 0; i < 3 * mesh.simplex_count; i++) {
        const pbw_index other = mesh.neighbors[i];
        if (other != PBW_NONE && other < i / 3 && input_uniform(&state) < 1.0 / 3) {
            line(d, mesh.simplices[i / 3 * 3 + (i + 1) % 3], mesh.simplices[i / 3 * 3 + (i + 2) % 3]);
        }
    }
    pbw_free(&mesh);
    for (i = 0; i < n; i++) {
        d->points[2 * i + 1] /= 4;
    }
    box(d, 0.5, 0.5, 1, 0);
}

/* Knight's moves over a sheared lattice. */
static void draw_lattice(drawing *d, int full)
{
    const int n = full ? 60 : 12;
    int i;
    for (i = 0; i < n * n; i++) {
        put(d, i % n, i / n + 2 * (i % n));
    }
    for (i = 0; i + 2 < n; i++) {
        line(d, (pbw_index)(i * n), (pbw_index)((i + 1) * n + n - 1));
    }
    rectangle(d, -1, -1, n, 3 * n);
}

static void draw_long(drawing *d, int full)
{
    const int n = full ? 20000 : 300, lines = full ? 100 : 8;
    uint64_t state = 4;
    int i;
    for (i = 0; i < n; i++) {
        put(d, input_uniform(&state), input_uniform(&state));
    }
    for (i = 0; i < lines; i++) {
        const double y = (i + 0.2 + 0.6 * input_uniform(&state)) / lines;
        stroke(d, -0.01, y, 1.01, (i + 0.2 + 0.6 * input_uniform(&state)) / lines);
    }
    box(d, 0.5, 0.5, 1, 0);
}

/* Boxes, each in its cell, turned by an angle with this sine. */
static void draw_boxes(drawing *d, int k, double sine)
{
    const double cosine = sqrt(1 - sine * sine);
    uint64_t state = 2;
    int i, j;
    for (i = 0; i < k * k; i++) {
        const double x = i % k + 0.3 * input_uniform(&state), y = i / k + 0.3 * input_uniform(&state);
        const double w = 0.1 + 0.4 * input_uniform(&state), h = 0.1 + 0.4 * input_uniform(&state);
        for (j = 0; j < 4; j++) {
            const double px = x + (j == 1 || j == 2 ? w : 0), py = y + (j > 1 ? h : 0);
            put(d, cosine * px - sine * py, sine * px + cosine * py);
        }
        ring(d, 4);
    }
    rectangle(d, -k, -k, 2 * k, 2 * k);
}

static void draw_navmesh(drawing *d, int full) { draw_boxes(d, full ? 100 : 6, 0); }
static void draw_navmesh_turned(drawing *d, int full) { draw_boxes(d, full ? 100 : 6, 0.0998); }

static void draw_plate(drawing *d, int full)
{
    (void)full;
    plate(d);
}

/* 50 slits, 0.02 wide. */
static void draw_comb(drawing *d, int full)
{
    const int n = full ? 50 : 10;
    int i;
    put(d, 0, 0);
    for (i = 0; i < n; i++) {
        put(d, i + 1, 0);
        put(d, i + 1, 1);
        put(d, i + 1.02, 1);
        put(d, i + 1.02, 0);
    }
    put(d, n + 1, 0);
    put(d, n + 1, 2);
    put(d, 0, 2);
    ring(d, d->point_count);
}

static void draw_hub(drawing *d, int spokes, double jitter)
{
    uint64_t state = 1;
    int i;
    box(d, 0, 0, 2, 0);
    put(d, 0, 0);
    for (i = 0; i < spokes; i++) {
        double c, s;
        input_turn((double)i / spokes + jitter * input_uniform(&state), &c, &s);
        line(d, 4, put(d, c, s));
    }
}

static void draw_spokes_7(drawing *d, int full) { (void)full, draw_hub(d, 7, 0); }
static void draw_spokes_12(drawing *d, int full) { (void)full, draw_hub(d, 12, 1e-3); }
static void draw_spokes_40(drawing *d, int full) { (void)full, draw_hub(d, 40, 1e-3); }

static void draw_wedge(drawing *d, double degrees)
{
    double c, s;
    input_turn(degrees / 360, &c, &s);
    box(d, 0, 0, 2, 0);
    put(d, 0, 0);
    line(d, 4, put(d, 1, 0.1));
    line(d, 4, put(d, c - 0.1 * s, s + 0.1 * c));
}

static void draw_wedge_30(drawing *d, int full) { (void)full, draw_wedge(d, 30); }
static void draw_wedge_10(drawing *d, int full) { (void)full, draw_wedge(d, 10); }
static void draw_wedge_1(drawing *d, int full) { (void)full, draw_wedge(d, 1); }
static void draw_wedge_001(drawing *d, int full) { (void)full, draw_wedge(d, 0.01); }

static void draw_nested(drawing *d, int full)
{
    int i;
    for (i = 1; i <= (full ? 40 : 9); i++) {
        box(d, 0, 0, i, i % 2);
    }
}

static void draw_star(drawing *d, int n, int k)
{
    int i;
    for (i = 0; i < n; i++) {
        double c, s;
        input_turn((double)i / n, &c, &s);
        put(d, c, s);
    }
    for (i = 0; i < n; i++) {
        line(d, (pbw_index)i, (pbw_index)((i + k) % n));
    }
    box(d, 0, 0, 2, 0);
}

static void draw_star_7(drawing *d, int full) { (void)full, draw_star(d, 7, 2); }
static void draw_star_31(drawing *d, int full) { (void)full, draw_star(d, 31, 13); }

/* Overlapping segments on lines through points of a lattice; ends are doubled; some segments are points. */
static void draw_overlaps(drawing *d, int full)
{
    const int n = full ? 60 : 10;
    int i;
    for (i = 0; i < n * n; i++) {
        put(d, i % n, i / n);
    }
    for (i = 1; i + 1 < n; i += 2) {
        const pbw_index first = (pbw_index)(i * n), last = (pbw_index)(i * n + n - 1);
        line(d, first, last);
        line(d, last - 2, first + 2);
        line(d, put(d, 0, i), put(d, n - 3, i));
        line(d, first, first);
    }
    rectangle(d, -1, -1, n, n);
}

/* Isolated points, segments with a free end or two. */
static void draw_dangling(drawing *d, int full)
{
    const int n = full ? 60 : 6;
    uint64_t state = 7;
    int i;
    for (i = 0; i < n * n; i++) {
        const double x = i % n + 0.2 + 0.6 * input_uniform(&state), y = i / n + 0.2 + 0.6 * input_uniform(&state);
        if (i % 3 == 0) {
            put(d, x, y);
        } else {
            stroke(d, i % n + 0.1, i / n + 0.1, x, y);
        }
    }
    rectangle(d, -1, -1, n + 1, n + 1);
}

static void draw_regions(drawing *d, int full)
{
    static const double holes[] = { 0, 0 };
    static const pbw_plane_region regions[] = { { -1.5, 0, 0.01 }, { 1.5, 0, 0.1 } };
    (void)full;
    box(d, 0, 0, 2, 0);
    box(d, 0, 0, 1, 0);
    stroke(d, 0, -2, 0, -1);
    stroke(d, 0, 1, 0, 2);
    d->input.holes = holes;
    d->input.hole_count = 1;
    d->input.regions = regions;
    d->input.region_count = 2;
}

/* Outlines of "D8S" in boxes of 10 x 14: rings of parabolas, ends and control points by turns. */
static void draw_text(drawing *d, int full)
{
    static const unsigned char at[] = {
        0,0, 0,7, 0,14, 9,14, 9,7, 9,0,
        2,2, 2,7, 2,12, 7,12, 7,7, 7,2,
        4,14, 8,14, 8,11, 8,8, 6,7, 9,6, 9,3, 9,0, 4,0, 0,0, 0,3, 0,6, 2,7, 0,8, 0,11, 0,14,
        4,12, 2,12, 2,10, 2,8, 4,8, 6,8, 6,10, 6,12,
        4,6, 2,6, 2,4, 2,2, 4,2, 7,2, 7,4, 7,6,
        8,12, 6,14, 4,14, 0,14, 0,10, 0,7, 4,6, 7,5, 7,4, 7,2, 4,2, 2,2, 1,3, 0,2, 0,1, 2,0, 4,0, 9,0, 9,4, 9,7,
        5,8, 2,9, 2,10, 2,12, 4,12, 6,12, 7,11, 8,11 };
    static const unsigned char curves[] = { 3, 3, 8, 4, 4, 14 }, letter[] = { 0, 0, 1, 1, 1, 2 };
    const int chords = full ? 40 : 8;
    const unsigned char *p = at;
    size_t i;
    int k, j;
    for (i = 0; i < sizeof curves; p += 4 * curves[i++]) {
        for (k = 0; k < curves[i]; k++) {
            const unsigned char *u = p + 4 * k, *v = p + 4 * ((k + 1) % curves[i]);
            for (j = 0; j < chords; j++) {
                const double t = (double)j / chords, a = (1 - t) * (1 - t), b = 2 * t * (1 - t), c = t * t;
                put(d, a * u[0] + b * u[2] + c * v[0] + 11.0 * letter[i], a * u[1] + b * u[3] + c * v[1]);
            }
        }
        ring(d, (size_t)(curves[i] * chords));
    }
}

/* Groups of four points that are 1e-9 apart. */
static void draw_clusters(drawing *d, int full)
{
    const int n = full ? 100 : 10;
    uint64_t state = 5;
    int i, k;
    for (i = 0; i < n; i++) {
        const double x = input_uniform(&state), y = input_uniform(&state);
        for (k = 0; k < 4; k++) {
            const double u = k % 2 + 0.2 * input_uniform(&state), v = k / 2 + 0.2 * input_uniform(&state);
            put(d, x + 1e-9 * u, y + 1e-9 * v);
        }
    }
    box(d, 0.5, 0.5, 1, 0);
}

/* A coast of whole numbers at 1e15, where doubles are 1/8 apart; rounded, it crosses itself. */
static void draw_far(drawing *d, int full)
{
    uint64_t state = 5;
    size_t i;
    coast(d, 0, 0, full ? 100000 : 10000, 500, &state);
    for (i = 0; i < 2 * d->point_count; i++) {
        d->points[i] = 1e15 + floor(d->points[i]);
    }
}

static void draw_tiny(drawing *d, int full)
{
    const int n = full ? 30 : 5;
    int i;
    for (i = 0; i < n * n; i++) {
        rectangle(d, 1e-300 * (i % n), 1e-300 * (i / n), 1e-300 * (i % n + 0.5), 1e-300 * (i / n + 0.5));
    }
}

/* Short segments, some of which cross. */
static void draw_crossed(drawing *d, int full)
{
    const int n = full ? 2000 : 100;
    const double most = 1 / sqrt(n);
    uint64_t state = 1;
    int i;
    for (i = 0; i < n; i++) {
        const double x = input_uniform(&state), y = input_uniform(&state);
        stroke(d, x, y, x + most * (input_uniform(&state) - 0.5), y + most * (input_uniform(&state) - 0.5));
    }
    box(d, 0.5, 0.5, 1, 0);
}

/* Long segments side by side that do not meet. */
static void draw_slivers(drawing *d, int full)
{
    const double apart = full ? 1e-4 : 1e-3;
    int i;
    for (i = 0; i < 10; i++) {
        stroke(d, -1, i * 0.1, 1, i * 0.1);
        stroke(d, -0.9, i * 0.1 + apart, 0.9, i * 0.1 + 2 * apart);
    }
    box(d, 0, 0.5, 2, 0);
}

/* Segments from one point, 1e-9 apart at their other ends. */
static void draw_needles(drawing *d, int full)
{
    int i;
    (void)full;
    box(d, 0, 0, 2, 0);
    put(d, -1, 0);
    for (i = 0; i < 10; i++) {
        line(d, 4, put(d, 1, 1e-9 * i));
    }
}

/* flags: for pbw_plane_make, beside refinement. */
typedef struct domain {
    const char *name;
    void (*make)(drawing *d, int full);
    pbw_plane_rule rule;
    unsigned flags;
} domain;

static const domain domains[] = {
    { "coasts", draw_coasts, PBW_PLANE_EVEN_ODD, 0 },
    { "coasts in a sea", draw_sea, PBW_PLANE_SEEDS, 0 },
    { "sheared", draw_sheared, PBW_PLANE_SEEDS, PBW_PLANE_SPLIT_CROSSINGS },
    { "sheared lattice", draw_lattice, PBW_PLANE_SEEDS, PBW_PLANE_SPLIT_CROSSINGS },
    { "long", draw_long, PBW_PLANE_SEEDS, PBW_PLANE_SPLIT_CROSSINGS },
    { "navmesh", draw_navmesh, PBW_PLANE_SEEDS, 0 },
    { "navmesh, turned", draw_navmesh_turned, PBW_PLANE_SEEDS, 0 },
    { "plate with rings", draw_plate, PBW_PLANE_SEEDS, 0 },
    { "comb", draw_comb, PBW_PLANE_EVEN_ODD, 0 },
    { "7 spokes", draw_spokes_7, PBW_PLANE_SEEDS, 0 },
    { "12 spokes", draw_spokes_12, PBW_PLANE_SEEDS, 0 },
    { "40 spokes", draw_spokes_40, PBW_PLANE_SEEDS, 0 },
    { "wedge of 30", draw_wedge_30, PBW_PLANE_SEEDS, 0 },
    { "wedge of 10", draw_wedge_10, PBW_PLANE_SEEDS, 0 },
    { "wedge of 1", draw_wedge_1, PBW_PLANE_SEEDS, 0 },
    { "wedge of 0.01", draw_wedge_001, PBW_PLANE_SEEDS, 0 },
    { "nested squares", draw_nested, PBW_PLANE_NONZERO, 0 },
    { "star {7/2}", draw_star_7, PBW_PLANE_NONZERO, PBW_PLANE_SPLIT_CROSSINGS },
    { "star {31/13}", draw_star_31, PBW_PLANE_NONZERO, PBW_PLANE_SPLIT_CROSSINGS },
    { "overlaps", draw_overlaps, PBW_PLANE_SEEDS, 0 },
    { "dangling", draw_dangling, PBW_PLANE_SEEDS, 0 },
    { "regions, a hole", draw_regions, PBW_PLANE_SEEDS, 0 },
    { "text", draw_text, PBW_PLANE_EVEN_ODD, 0 },
    { "clusters of 1e-9", draw_clusters, PBW_PLANE_SEEDS, 0 },
    { "at 1e15", draw_far, PBW_PLANE_EVEN_ODD, PBW_PLANE_SPLIT_CROSSINGS },
    { "grid of 1e-300", draw_tiny, PBW_PLANE_EVEN_ODD, 0 },
    { "crossed", draw_crossed, PBW_PLANE_SEEDS, PBW_PLANE_SPLIT_CROSSINGS },
    { "slivers", draw_slivers, PBW_PLANE_SEEDS, 0 },
    { "needles of 1e-9", draw_needles, PBW_PLANE_SEEDS, 0 }
};
enum { DOMAIN_COUNT = sizeof domains / sizeof *domains };

/* ---- what refinement has to reach */

static double domain_angle(const double *a, const double *b, const double *c)           /* at a, in degrees */
{
    const double x = (b[0] - a[0]) * (c[0] - a[0]) + (b[1] - a[1]) * (c[1] - a[1]);
    const double y = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    return atan2(fabs(y), x) * (360 / INPUT_TURN);
}

static double domain_least_angle(const pbw_plane *plane, size_t triangle)
{
    const double *p[3];
    double least = 180;
    int k;
    for (k = 0; k < 3; k++) {
        p[k] = plane->points + 2 * (size_t)plane->triangles[3 * triangle + (size_t)k];
    }
    for (k = 0; k < 3; k++) {
        least = fmin(least, domain_angle(p[k], p[(k + 1) % 3], p[(k + 2) % 3]));
    }
    return least;
}

/* Returns whether two segments of the input meet at less than 60 degrees. */
static int domain_is_small(const drawing *d, size_t s, size_t t)
{
    const double *p[4];
    int i, j, on;
    for (i = 0; i < 4; i++) {
        p[i] = d->points + 2 * (size_t)d->segments[2 * (i < 2 ? s : t) + (size_t)(i % 2)];
    }
    for (i = 0; i < 2; i++) {
        for (j = 2; j < 4; j++) {
            if (memcmp(p[i], p[j], 2 * sizeof(double)) == 0) {
                return pbw_orient2(p[i], p[1 - i], p[5 - j]) != 0 && domain_angle(p[i], p[1 - i], p[5 - j]) < 60;
            }
        }
    }
    on = pbw_orient2(p[0], p[1], p[2]) * pbw_orient2(p[0], p[1], p[3]) <= 0
      && pbw_orient2(p[2], p[3], p[0]) * pbw_orient2(p[2], p[3], p[1]) <= 0;
    if (on) {
        const double v[2] = { p[0][0] + (p[3][0] - p[2][0]), p[0][1] + (p[3][1] - p[2][1]) };
        const double angle = domain_angle(p[0], p[1], v);
        on = pbw_orient2(p[0], p[1], p[2]) != pbw_orient2(p[0], p[1], p[3]) && (angle < 60 || angle > 120);
    }
    return on;
}

/* What is at the corners of triangles that are sharper than wanted. */
typedef struct domain_verdict {
    double least, least_free;              /* least angle: of all, of triangles at no small angle of the input */
    size_t sharp, sharp_free;              /* triangles with smaller angles than wanted: all, at no small angle */
} domain_verdict;

/* Segments at each point: those of point v are item[first[v]] .. item[first[v + 1] - 1]. */
typedef struct domain_stars { size_t *first; pbw_index *item; } domain_stars;

static domain_stars domain_find_stars(const pbw_plane *plane)
{
    domain_stars stars;
    size_t i, k, pass;
    stars.first = (size_t *)zoo_grow(NULL, (plane->point_count + 2) * sizeof *stars.first);
    stars.item = (pbw_index *)zoo_grow(NULL, (2 * plane->edge_first[plane->edge_count] + 1) * sizeof *stars.item);
    memset(stars.first, 0, (plane->point_count + 2) * sizeof *stars.first);
    for (pass = 0; pass < 2; pass++) {
        for (i = 0; i < 2 * plane->edge_count; i++) {
            for (k = plane->edge_first[i / 2]; k < plane->edge_first[i / 2 + 1]; k++) {
                if (pass == 0) {
                    stars.first[plane->edges[i] + 2]++;
                } else {
                    stars.item[stars.first[plane->edges[i] + 1]++] = plane->edge_segments[k];
                }
            }
        }
        for (i = 2; pass == 0 && i < plane->point_count + 2; i++) {
            stars.first[i] += stars.first[i - 1];
        }
    }
    return stars;
}

/* Returns whether a triangle has corners on two segments that meet at a small angle. */
static int domain_is_excused(const drawing *d, const domain_stars *stars, const pbw_index *corner)
{
    int i, j, small = 0;
    size_t a, b;
    for (i = 0; i < 3; i++) {
        for (j = 0; j <= i; j++) {
            for (a = stars->first[corner[i]]; a < stars->first[corner[i] + 1] && !small; a++) {
                for (b = stars->first[corner[j]]; b < stars->first[corner[j] + 1] && !small; b++) {
                    small = stars->item[a] != stars->item[b] && domain_is_small(d, stars->item[a], stars->item[b]);
                }
            }
        }
    }
    return small;
}

static domain_verdict domain_judge(const drawing *d, const pbw_plane *plane, double angle)
{
    const domain_stars stars = domain_find_stars(plane);
    domain_verdict v;
    size_t i;
    v.least = v.least_free = 180;
    v.sharp = v.sharp_free = 0;
    for (i = 0; i < plane->triangle_count; i++) {
        const double least = domain_least_angle(plane, i);
        const int sharp = least < angle - 1e-6;
        const int excused = sharp && domain_is_excused(d, &stars, plane->triangles + 3 * i);
        v.least = fmin(v.least, least);
        v.least_free = excused ? v.least_free : fmin(v.least_free, least);
        v.sharp += (size_t)sharp;
        v.sharp_free += (size_t)(sharp && !excused);
    }
    free(stars.first);
    free(stars.item);
    return v;
}

#endif
