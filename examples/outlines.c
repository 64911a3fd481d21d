/* outlines.c: letters from curves and polygons that overlap: crossings are split, and what the outlines wind round is
   filled, meshed with angles of 30 degrees and smoothed.
   cc -O2 -I. -Iexamples/lib examples/outlines.c -o outlines -lpthread -lm && ./outlines [letters.svg]
   Prints expected/outlines.txt; the exit status is 1 if a letter is not in one piece, or an angle is too small. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#define PBW_ADAPT2_IMPLEMENTATION
#include "pbw_adapt2.h"
#include "draw.h"

enum { MOST = 1000, STEPS = 8 };

static double points[2 * MOST];
static pbw_index segments[2 * MOST];
static size_t count, begun;                          /* points; where the ring in work begins */

static void corner(double x, double y)
{
    points[2 * count] = x;
    points[2 * count++ + 1] = y;
}

/* A quadratic curve from the last point, towards x, y, to u, v. */
static void curve(double x, double y, double u, double v)
{
    const double a = points[2 * count - 2], b = points[2 * count - 1];
    for (int i = 1; i <= STEPS; i++) {
        const double t = (double)i / STEPS, s = 1 - t;
        corner(s * s * a + 2 * s * t * x + t * t * u, s * s * b + 2 * s * t * y + t * t * v);
    }
}

static void close_ring(void)
{
    for (size_t i = begun; i < count; i++) {
        segments[2 * i] = (pbw_index)i;
        segments[2 * i + 1] = (pbw_index)(i + 1 < count ? i + 1 : begun);
    }
    begun = count;
}

/* A round of radius r; turn = 1: filled, -1: a hole in what is round it. */
static void round_ring(double x, double y, double r, double turn)
{
    const double d = turn * r, e = 0.41421356237309503;          /* tan 22.5: eight curves make a round */
    corner(x + r, y);
    curve(x + r, y + e * d, x + r * 0.70710678118654752, y + d * 0.70710678118654752);
    curve(x + e * r, y + d, x, y + d);
    curve(x - e * r, y + d, x - r * 0.70710678118654752, y + d * 0.70710678118654752);
    curve(x - r, y + e * d, x - r, y);
    curve(x - r, y - e * d, x - r * 0.70710678118654752, y - d * 0.70710678118654752);
    curve(x - e * r, y - d, x, y - d);
    curve(x + e * r, y - d, x + r * 0.70710678118654752, y - d * 0.70710678118654752);
    curve(x + r, y - e * d, x + r, y);
    count--;                                         /* the first point again */
    close_ring();
}

static void bar(double x, double y, double right, double top)
{
    corner(x, y);
    corner(right, y);
    corner(right, top);
    corner(x, top);
    close_ring();
}

static void stroke(double x, double y, double u, double v, double wide)
{
    corner(x, y);
    corner(x + wide, y);
    corner(u + wide, v);
    corner(u, v);
    close_ring();
}

int main(int argc, char **argv)
{
    const double lines[2] = { 0.7, 2.5 };
    pbw_plane_input input = { 0 };
    pbw_plane_options options = { 0 };
    pbw_plane plane = { 0 };
    int failed;
    bar(0, -1, 0.4, 2);                              /* p: a stem that overlaps a round with a hole */
    round_ring(1, 1, 1, 1);
    round_ring(1, 1, 0.6, -1);
    bar(2.5, 0, 2.9, 3);                             /* b */
    round_ring(3.5, 1, 1, 1);
    round_ring(3.5, 1, 0.6, -1);
    stroke(5.6, 0, 5, 2, 0.4);                       /* w: four strokes, counter-clockwise each */
    stroke(5.6, 0, 6.2, 1.6, 0.4);
    stroke(6.8, 0, 6.2, 1.6, 0.4);
    stroke(6.8, 0, 7.4, 2, 0.4);
    input.points = points;
    input.point_count = input.segment_count = count;
    input.segments = segments;
    options.rule = PBW_PLANE_NONZERO;
    options.flags = PBW_PLANE_SPLIT_CROSSINGS;
    if (pbw_plane_make(&input, &options, &plane) != PBW_OK) {
        puts(plane.what);
        return 1;
    }
    printf("%d outlines, %d places where they cross\n", 10, (int)(plane.point_count - plane.input_count));
    /* Lines inside of letters go: the border of the triangles is the domain now. */
    pbw_plane letters = { 0 };
    options.flags = PBW_PLANE_REFINE;
    options.size = 0.2;
    pbw_plane_input triangles = { 0 };
    triangles.points = plane.points;
    triangles.point_count = plane.point_count;
    pbw_status status = pbw_plane_from_triangles(&triangles, plane.triangles, NULL, plane.triangle_count, &options,
                                                 &letters);
    pbw_plane_free(&plane);
    if (status != PBW_OK || pbw_plane_smooth(&letters, PBW_PLANE_ODT, 10, NULL, NULL) != PBW_OK) {
        puts(letters.what);
        return 1;
    }
    const pbw_plane_quality q = pbw_plane_quality_of(&letters, PBW_PLANE_MIN_ANGLE);
    unsigned *fill = (unsigned *)malloc((letters.triangle_count + 1) * sizeof *fill);
    static const unsigned colours[3] = { 0x2a7fa8, 0xe09f3e, 0x9e2a2b };
    for (size_t i = 0; fill != NULL && i < letters.triangle_count; i++) {
        const double *a = letters.points + 2 * letters.triangles[3 * i];
        fill[i] = blend(colours[a[0] < 2.2 ? 0 : a[0] < 4.7 ? 1 : 2], 0xffffff, 0.3 + 0.03 * (double)(i % 13));
    }
    printf("%d letters, no angle below %.0f degrees\n", (int)letters.region_count, floor(q.least + 1e-9));
    failed = fill == NULL || letters.region_count != 3 || q.least < 30 - 1e-9
          || (argc > 1 && draw(argv[1], &letters, fill, lines));
    free(fill);
    pbw_plane_free(&letters);
    return failed;
}
