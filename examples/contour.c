/* contour.c: the bright parts of a picture as a mesh: contours by marching triangles, then angles of 30 degrees.
   cc -O2 -I. -Iexamples/lib examples/contour.c -o contour -lpthread -lm && ./contour [mesh.svg [picture.pgm]]
   The picture is binary greyscale (P5, 8 bits), or else made: drops that flow together.  Prints expected/contour.txt;
   the exit status is 1 if the area of the mesh is not that of the contours. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#include "draw.h"

typedef struct picture { int wide, high; unsigned char *grey; } picture;

static double level(const picture *p, int x, int y)              /* above 0: inside; dark beyond the border */
{
    const int out = x < 0 || y < 0 || x >= p->wide || y >= p->high;
    return (out ? 0 : p->grey[(size_t)y * (size_t)p->wide + (size_t)x]) - 127.5;
}

static int make_picture(picture *p)
{
    static const double drop[7][3] = { { 60, 60, 26 }, { 110, 80, 30 }, { 160, 60, 22 }, { 90, 150, 34 },
                                       { 170, 140, 30 }, { 215, 90, 18 }, { 130, 115, -14 } };
    p->wide = 260;
    p->high = 200;
    p->grey = (unsigned char *)malloc((size_t)(p->wide * p->high));
    for (int i = 0; p->grey != NULL && i < p->wide * p->high; i++) {
        double sum = 0;
        for (int k = 0; k < 7; k++) {
            const double x = i % p->wide - drop[k][0], y = i / p->wide - drop[k][1];
            sum += drop[k][2] * fabs(drop[k][2]) / (x * x + y * y + 20);
        }
        p->grey[i] = (unsigned char)fmax(0, fmin(255, 127 * sum));
    }
    return p->grey != NULL;
}

static int read_picture(const char *path, picture *p)
{
    FILE *file = fopen(path, "rb");
    int most = 0, ok = file != NULL && fscanf(file, "P5 %d %d %d", &p->wide, &p->high, &most) == 3 && most == 255
          && p->wide > 0 && p->high > 0 && p->wide < 20000 && p->high < 20000;
    if (ok) {
        const size_t n = (size_t)p->wide * (size_t)p->high;
        p->grey = (unsigned char *)malloc(n);
        fgetc(file);
        ok = p->grey != NULL && fread(p->grey, 1, n, file) == n;
    }
    if (file != NULL) {
        fclose(file);
    }
    return ok || !fprintf(stderr, "%s: no binary PGM file of 8 bits\n", path);
}

typedef struct contours { double *points; pbw_index *segments, *number; size_t count, lines; int wide; } contours;

/* The point of a contour between two pixels, made when it is first met: the edge has the pixel that is first, and one
   of three directions. */
static pbw_index cut(contours *c, const picture *p, const int a[2], const int b[2])
{
    const int swap = a[1] > b[1] || (a[1] == b[1] && a[0] > b[0]), *s = swap ? b : a, *t = swap ? a : b;
    const int way = t[0] == s[0] ? 0 : t[1] == s[1] ? 1 : 2;
    pbw_index *number = c->number + 3 * ((size_t)(s[1] + 1) * (size_t)c->wide + (size_t)(s[0] + 1)) + way;
    if (*number == 0) {
        const double u = level(p, s[0], s[1]), v = level(p, t[0], t[1]), at = u / (u - v);
        c->points[2 * c->count] = s[0] + at * (t[0] - s[0]);
        c->points[2 * c->count + 1] = -(s[1] + at * (t[1] - s[1]));
        *number = (pbw_index)++c->count;
    }
    return *number - 1;
}

/* The contour through one triangle of pixels: a line that parts one corner from the other two. */
static void march(contours *c, const picture *p, const int corner[3][2])
{
    for (int k = 0; k < 3; k++) {
        const int *a = corner[k], *b = corner[(k + 1) % 3], *d = corner[(k + 2) % 3];
        const int in = level(p, a[0], a[1]) > 0;
        if (in != (level(p, b[0], b[1]) > 0) && in != (level(p, d[0], d[1]) > 0)) {
            c->segments[2 * c->lines] = cut(c, p, a, in ? b : d);
            c->segments[2 * c->lines++ + 1] = cut(c, p, a, in ? d : b);
        }
    }
}

int main(int argc, char **argv)
{
    const double thin[2] = { 0.4, 1.6 };
    picture p = { 0 };
    contours c = { 0 };
    pbw_plane_input input = { 0 };
    pbw_plane_options options = { 0 };
    pbw_plane plane = { 0 };
    double area = 0, meshed = 0;
    if (argc > 2 ? !read_picture(argv[2], &p) : !make_picture(&p)) {
        return 1;
    }
    const size_t cells = (size_t)(p.wide + 2) * (size_t)(p.high + 2);
    c.wide = p.wide + 2;
    c.points = (double *)malloc(6 * cells * sizeof *c.points);
    c.segments = (pbw_index *)malloc(4 * cells * sizeof *c.segments);
    c.number = (pbw_index *)calloc(3 * cells, sizeof *c.number);
    if (c.points == NULL || c.segments == NULL || c.number == NULL) {
        return 1;
    }
    for (int y = -1; y < p.high; y++) {
        for (int x = -1; x < p.wide; x++) {
            const int one[3][2] = { { x, y }, { x + 1, y }, { x + 1, y + 1 } };
            const int other[3][2] = { { x, y }, { x + 1, y + 1 }, { x, y + 1 } };
            march(&c, &p, one);
            march(&c, &p, other);
        }
    }
    for (size_t i = 0; i < c.lines; i++) {
        const double *a = c.points + 2 * c.segments[2 * i], *b = c.points + 2 * c.segments[2 * i + 1];
        area += (a[0] * b[1] - a[1] * b[0]) / 2;
    }
    input.points = c.points;
    input.point_count = c.count;
    input.segments = c.segments;
    input.segment_count = c.lines;
    options.rule = PBW_PLANE_NONZERO;
    options.flags = PBW_PLANE_REFINE;
    pbw_status status = pbw_plane_make(&input, &options, &plane);
    unsigned *fill = (unsigned *)calloc(plane.triangle_count + 1, sizeof *fill);
    for (size_t i = 0; fill != NULL && i < plane.triangle_count; i++) {
        const pbw_index *v = plane.triangles + 3 * i;
        const double *a = plane.points + 2 * v[0], *b = plane.points + 2 * v[1], *d = plane.points + 2 * v[2];
        const double twice = (b[0] - a[0]) * (d[1] - a[1]) - (b[1] - a[1]) * (d[0] - a[0]);
        const int x = (int)((a[0] + b[0] + d[0]) / 3 + 0.5), y = (int)(-(a[1] + b[1] + d[1]) / 3 + 0.5);
        meshed += twice / 2;
        fill[i] = blend(0xf4a261, 0xfff3c4, level(&p, x, y) / 127.5);
    }
    printf("%d parts, %.0f pixels %s\n", (int)plane.region_count, fabs(area), plane.what);
    status = status == PBW_OK && argc > 1 && draw(argv[1], &plane, fill, thin) ? PBW_ERROR_ARGUMENT : status;
    free(p.grey);
    free(c.points);
    free(c.segments);
    free(c.number);
    free(fill);
    pbw_plane_free(&plane);
    return status != PBW_OK || fabs(fabs(area) - meshed) > 1e-9 * meshed;
}
