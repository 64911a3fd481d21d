/* breaklines.c: a surveyed terrain with a dam.  The edges of the dam are break lines: as segments they keep triangles
   from cutting its crest and feet.
   cc -O2 -I. -Iexamples/lib examples/breaklines.c -o breaklines -lpthread -lm
   breaklines with.svg without.svg also draws both, lit from the north-west.  Prints expected/breaklines.txt; the exit
   status is 1 unless the break lines make the mean error of heights at most a fifth. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#include "draw.h"

enum { BENDS = 7, LINES = 4, SURVEYED = 700, COUNT = LINES * BENDS + 4 + SURVEYED, WIDE = 600, HIGH = 400 };

static const double bend[BENDS][2] = { { 0, 120 }, { 110, 180 }, { 190, 150 }, { 300, 230 }, { 420, 210 },
                                       { 500, 290 }, { 600, 260 } };     /* of the middle of the dam */
static const double offset[LINES] = { -30, -8, 8, 30 };                  /* of its feet and crests */
static double points[2 * COUNT], height[COUNT];

static double ground(double x, double y)                                 /* metres */
{
    int k = 0;
    while (k < BENDS - 2 && x > bend[k + 1][0]) {
        k++;
    }
    const double t = (x - bend[k][0]) / (bend[k + 1][0] - bend[k][0]);
    const double off = fabs(y - (bend[k][1] + t * (bend[k + 1][1] - bend[k][1])));
    return 5 + 0.01 * x + 8e-5 * (y - 200) * (y - 200) + fmax(0, fmin(15, 15 * (30 - off) / 22));
}

static void survey(void)
{
    unsigned long long state = 3;
    size_t n = 0;
    for (int line = 0; line < LINES; line++) {
        for (int k = 0; k < BENDS; k++, n++) {
            points[2 * n] = bend[k][0];
            points[2 * n + 1] = bend[k][1] + offset[line];
        }
    }
    for (int k = 0; k < 4; k++, n++) {
        points[2 * n] = k % 2 * WIDE;
        points[2 * n + 1] = k / 2 * HIGH;
    }
    for (; n < COUNT; n++) {
        for (int k = 0; k < 2; k++) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            points[2 * n + (size_t)k] = (k == 0 ? WIDE : HIGH) * ((double)(state >> 11) / 9007199254740992.0);
        }
    }
    for (n = 0; n < COUNT; n++) {
        height[n] = ground(points[2 * n], points[2 * n + 1]);
    }
}

/* Sums the errors at whole metres in a triangle; returns its colour, by the light on it. */
static unsigned judge(const pbw_index *v, double *sum, double *count)
{
    const double *a = points + 2 * v[0], *b = points + 2 * v[1], *c = points + 2 * v[2];
    const double bx = b[0] - a[0], by = b[1] - a[1], cx = c[0] - a[0], cy = c[1] - a[1], twice = bx * cy - by * cx;
    const double bz = height[v[1]] - height[v[0]], cz = height[v[2]] - height[v[0]];
    const double east = (bz * cy - cz * by) / twice, north = (cz * bx - bz * cx) / twice;
    for (int y = (int)fmin(a[1], fmin(b[1], c[1])); y <= fmax(a[1], fmax(b[1], c[1])); y++) {
        for (int x = (int)fmin(a[0], fmin(b[0], c[0])); x <= fmax(a[0], fmax(b[0], c[0])); x++) {
            const double u = ((x - a[0]) * cy - (y - a[1]) * cx) / twice;
            const double w = (bx * (y - a[1]) - by * (x - a[0])) / twice;
            if (u >= 0 && w >= 0 && u + w < 1) {
                *sum += fabs(height[v[0]] + u * bz + w * cz - ground(x, y));
                *count += 1;
            }
        }
    }
    return blend(0x33402c, 0xf2ecd0, (0.6 + 0.55 * (east - north)) / sqrt(1 + east * east + north * north));
}

/* The mean error of heights; below 0 after a failure. */
static double triangulate(const pbw_plane_input *input, const char *path)
{
    const double lines[2] = { 0.3, 2 };
    pbw_plane plane = { 0 };
    double sum = 0, count = 0;
    if (pbw_plane_make(input, NULL, &plane) != PBW_OK) {
        puts(plane.what);
        return -1;
    }
    unsigned *fill = (unsigned *)malloc((plane.triangle_count + 1) * sizeof *fill);
    for (size_t i = 0; fill != NULL && i < plane.triangle_count; i++) {
        fill[i] = judge(plane.triangles + 3 * i, &sum, &count);
    }
    const int failed = fill == NULL || (path != NULL && draw(path, &plane, fill, lines));
    free(fill);
    pbw_plane_free(&plane);
    return failed ? -1 : sum / count;
}

int main(int argc, char **argv)
{
    pbw_index segments[2 * LINES * (BENDS - 1)];
    pbw_plane_input input = { 0 };
    survey();
    input.points = points;
    input.point_count = COUNT;
    const double without = triangulate(&input, argc > 2 ? argv[2] : NULL);
    for (pbw_index i = 0; i < LINES * (BENDS - 1); i++) {
        segments[2 * i] = i / (BENDS - 1) * BENDS + i % (BENDS - 1);
        segments[2 * i + 1] = segments[2 * i] + 1;
    }
    input.segments = segments;
    input.segment_count = LINES * (BENDS - 1);
    const double with = triangulate(&input, argc > 1 ? argv[1] : NULL);
    printf("mean error: %.2f m, with break lines %.2f m\n", without, with);
    return !(without > 0 && with > 0 && 5 * with <= without);
}
