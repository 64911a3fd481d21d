/* terrain.c: an airborne laser scan triangulated in the plane, its heights carried along: heights anywhere by
   interpolation, a shaded relief with contour lines.
   cc -O2 -I. -Iexamples/lib examples/terrain.c -o terrain -lpthread -lm
   terrain relief.pgm relief.html also writes a picture and a page to look around in.  Prints expected/terrain.txt: a
   map, 3 metres a step. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_IO_IMPLEMENTATION
#include "pbw_io.h"
#define PBW_VIEW_IMPLEMENTATION
#include "pbw_view.h"
#include <math.h>
#include <stdio.h>

enum { LINES = 150, PULSES = 250, WIDTH = 720, HEIGHT = 480 };

typedef struct sample { double x, y, z; } sample;

static sample samples[LINES * PULSES];

static double ground(double x, double y)           /* metres, over 300 m by 200 m */
{
    double u = (x - 90) / 40, v = (y - 110) / 30, s = (x - 220) / 50, t = (y - 60) / 45;
    return 30 / (1 + u * u + v * v) + 22 / (1 + s * s + t * t) + x / 60;
}

/* Scan lines across the flight, with jitter, in whole centimetres as scanners store them; a lake gives no echo. */
static size_t scan(void)
{
    unsigned long long state = 1;
    size_t count = 0;
    for (int i = 0; i < LINES * PULSES; i++) {
        double r[3], x, y;
        for (int k = 0; k < 3; k++) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            r[k] = (double)(state >> 11) / 9007199254740992.0;
        }
        x = 300.0 * (i / PULSES) / (LINES - 1) + r[0];
        y = 200.0 * (i % PULSES) / (PULSES - 1) + r[1];
        if ((x - 160) * (x - 160) + 4 * (y - 150) * (y - 150) > 900) {
            sample s = { floor(100 * x) / 100, floor(100 * y) / 100,
                         floor(100 * (ground(x, y) + 0.2 * r[2] - 0.1)) / 100 };
            samples[count++] = s;
        }
    }
    return count;
}

/* The triangle with q in it, walking from t across edges that have q on their far side; PBW_NONE outside all. */
static pbw_index locate(const pbw_mesh *mesh, pbw_index t, const double *q)
{
    int i = 0;
    while (t != PBW_NONE && i < 3) {
        const pbw_index *c = mesh->simplices + 3 * (size_t)t;
        for (i = 0; i < 3; i++) {
            if (pbw_orient2(mesh->points + 2 * c[(i + 1) % 3], mesh->points + 2 * c[(i + 2) % 3], q) < 0) {
                t = mesh->neighbors[3 * (size_t)t + (size_t)i];
                break;
            }
        }
    }
    return t;
}

/* The plane over triangle t: its height at q, and its slopes. */
static double height_at(const pbw_mesh *mesh, pbw_index t, const double *q, double slope[2])
{
    const pbw_index *c = mesh->simplices + 3 * (size_t)t;
    const sample *a = samples + c[0], *b = samples + c[1], *d = samples + c[2];
    double ux = b->x - a->x, uy = b->y - a->y, uz = b->z - a->z, vx = d->x - a->x, vy = d->y - a->y, vz = d->z - a->z;
    double area = ux * vy - uy * vx;
    slope[0] = (uz * vy - vz * uy) / area;
    slope[1] = (ux * vz - vx * uz) / area;
    return a->z + slope[0] * (q[0] - a->x) + slope[1] * (q[1] - a->y);
}

static int write_page(const char *path, const pbw_mesh *mesh)
{
    static double heights[LINES * PULSES];
    pbwview_options options = { .title = "Terrain", .heights = heights, .colour = "height" };
    pbwio_error error;
    for (size_t i = 0; i < mesh->point_count; i++) {
        heights[i] = samples[i].z;
    }
    if (pbwview_write(path, mesh, &options, &error) != PBWIO_OK) {
        printf("%s\n", error.text);
        return 1;
    }
    return 0;
}

int main(int argc, char **argv)
{
    static unsigned char picture[WIDTH * HEIGHT];
    static char map[HEIGHT / 24][WIDTH / 10 + 1];
    static double row[WIDTH];                       /* heights of the row above */
    size_t count = scan(), inside = 0;
    pbw_options options = { 0 };
    pbw_mesh mesh = { 0 };
    pbw_status status;
    pbw_index t = 0;
    double sum = 0;
    int failed;
    options.stride = sizeof(sample);                /* x and y are read, z is ours */
    status = pbw_triangulate(2, &samples[0].x, NULL, count, &options, &mesh);
    if (status != PBW_OK) {
        printf("%s\n", pbw_status_string(status));
        return 1;
    }
    printf("%zu echoes, %zu at a place that had one, %zu triangles\n", count, mesh.duplicate_count,
           mesh.simplex_count);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        int x = i % WIDTH, y = i / WIDTH;
        const double q[2] = { 300 * (x + 0.5) / WIDTH, 200 - 200 * (y + 0.5) / HEIGHT };
        pbw_index found = locate(&mesh, t, q);
        double slope[2], h, shade;
        if (found == PBW_NONE) {
            map[y / 24][x / 10] = ' ';
            continue;
        }
        t = found;
        h = height_at(&mesh, t, q, slope);
        shade = (1 + 0.7 * slope[0] - 0.7 * slope[1]) / sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
        picture[i] = (unsigned char)(shade < 0 ? 0 : shade > 1.5 ? 255 : 170 * shade);
        if (y > 0 && x > 0 && (floor(h / 3) < floor(row[x] / 3) || floor(h / 3) > floor(row[x] / 3) ||
                               floor(h / 3) < floor(row[x - 1] / 3) || floor(h / 3) > floor(row[x - 1] / 3))) {
            picture[i] /= 2;                        /* a contour line passes between this pixel and its neighbours */
        }
        row[x] = h;
        inside++;
        sum += (h - ground(q[0], q[1])) * (h - ground(q[0], q[1]));
        map[y / 24][x / 10] = "0123456789abcdefghij"[(int)(h / 3)];
    }
    for (int y = 0; y < HEIGHT / 24; y++) {
        printf("%s\n", map[y]);
    }
    printf("%zu of %d pixels inside; off the true ground by %.3f m (root mean square)\n", inside, WIDTH * HEIGHT,
           sqrt(sum / (double)inside));
    if (argc > 1) {
        FILE *file = fopen(argv[1], "wb");
        if (file == NULL || fprintf(file, "P5\n%d %d\n255\n", WIDTH, HEIGHT) < 0 ||
            fwrite(picture, 1, sizeof picture, file) != sizeof picture || fclose(file) != 0) {
            perror(argv[1]);
            return 1;
        }
    }
    failed = argc > 2 && write_page(argv[2], &mesh);
    pbw_free(&mesh);
    return failed;
}
