/* raster.c: soundings along the tracks of a ship, made a raster of depths by natural neighbours.
   cc -O2 -I. -Iexamples/lib examples/raster.c -o raster -lpthread -lm
   raster depths.pgm [linear.pgm] also writes it, lit from the north west, and that of linear interpolation.
   Soundings crowd along the tracks and are rare between them: there triangles are long and thin, and linear
   interpolation shows them as facets.  A place's natural neighbours are those whose Voronoi cells its own would take
   from (Sibson 1981).  Prints expected/raster.txt: how far both are off the true ground. */
#define PBW_IMPLEMENTATION
#define PBW_QUERY_IMPLEMENTATION
#include "pbw_query.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { TRACKS = 28, PINGS = 160, COUNT = TRACKS * PINGS, WIDTH = 600, HEIGHT = 400, PIXELS = WIDTH * HEIGHT };
static double points[2 * COUNT], depth[COUNT], pixels[2 * PIXELS], value[PIXELS];

static double ground(double x, double y)
{
    const double u = x - 3.6, v = y - 1.8, ridge = y - 2.6 + 0.5 * sin(x);
    return exp(-(u * u + v * v)) + 0.8 * exp(-4 * ridge * ridge) + 0.25 * sin(1.7 * x) * cos(2.3 * y);
}

static double random_number(void)                    /* in [-1, 1) */
{
    static unsigned long long state = 1;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) / 4503599627370496.0 - 1;
}

static void sound(void)
{
    for (int i = 0; i < COUNT; i++) {
        const double along = (i % PINGS) / (PINGS - 1.0), track = (i / PINGS + 0.5) / TRACKS;
        double *p = points + 2 * i;
        p[0] = 6.4 * along - 0.2 + 0.01 * random_number();
        p[1] = 4.4 * track - 0.2 + 0.04 * sin(5 * along + 9 * track) + 0.01 * random_number();
        depth[i] = ground(p[0], p[1]);
    }
    for (int i = 0; i < PIXELS; i++) {
        pixels[2 * i] = 6.0 * (i % WIDTH + 0.5) / WIDTH;
        pixels[2 * i + 1] = 4.0 * (HEIGHT - i / WIDTH - 0.5) / HEIGHT;
    }
}

/* The value of each pixel; pixels outside of the hull keep 0.  Returns a status. */
static pbw_status fill(const pbw_mesh *mesh, pbw_scheme scheme)
{
    pbw_lists lists = { 0 };
    const pbw_status status = pbw_coordinates(mesh, pixels, PIXELS, scheme, NULL, &lists);
    for (size_t i = 0; i < PIXELS && status == PBW_OK; i++) {
        value[i] = 0;
        for (size_t k = lists.first[i]; k < lists.first[i + 1]; k++) {
            value[i] += lists.value[k] * depth[lists.item[k]];
        }
    }
    pbw_lists_free(&lists);
    return status;
}

static int write_relief(const char *path)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        perror(path);
        return 0;
    }
    fprintf(file, "P5\n%d %d\n255\n", WIDTH, HEIGHT);
    for (int i = 0; i < PIXELS; i++) {
        const int x = i % WIDTH, left = x > 0 ? i - 1 : i, right = x + 1 < WIDTH ? i + 1 : i;
        const int above = i >= WIDTH ? i - WIDTH : i, below = i + WIDTH < PIXELS ? i + WIDTH : i;
        const double u = 30 * (value[right] - value[left]), v = 30 * (value[above] - value[below]);
        const double light = (0.7 + 0.5 * (u - v)) / sqrt(1 + u * u + v * v) + 0.1 * value[i];
        fputc((int)fmin(255, fmax(0, 230 * light - 20)), file);
    }
    if (ferror(file) | fclose(file)) {
        perror(path);
        return 0;
    }
    return 1;
}

int main(int argc, char **argv)
{
    static const char *const names[2] = { "natural neighbours", "linear" };
    static const pbw_scheme schemes[2] = { PBW_SIBSON, PBW_BARYCENTRIC };
    pbw_mesh mesh = { 0 };
    pbw_status status;
    int written = 1;
    sound();
    status = pbw_triangulate(2, points, NULL, COUNT, NULL, &mesh);
    printf("%d soundings, %d x %d pixels\n", COUNT, WIDTH, HEIGHT);
    for (int k = 0; k < 2 && status == PBW_OK; k++) {
        status = fill(&mesh, schemes[k]);
        double sum = 0, worst = 0;
        for (int i = 0; i < PIXELS; i++) {
            const double error = fabs(value[i] - ground(pixels[2 * i], pixels[2 * i + 1]));
            sum += error * error;
            worst = fmax(worst, error);
        }
        printf("%-18s off by %.1e (root mean square), %.1e at most\n", names[k], sqrt(sum / PIXELS), worst);
        if (argc > k + 1 && status == PBW_OK) {
            written &= write_relief(argv[k + 1]);
        }
    }
    if (status != PBW_OK) {
        printf("%s\n", pbw_status_string(status));
    }
    pbw_free(&mesh);
    return status != PBW_OK || !written;
}
