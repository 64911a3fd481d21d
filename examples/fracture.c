/* fracture.c: a gem broken into convex pieces by a blow: the Voronoi cells of points that crowd where it hit.
   cc -O2 -I. -Iexamples/lib examples/fracture.c -o fracture -lpthread -lm
   fracture [pieces.obj [pieces.svg]] writes the pieces, and a picture of them, moved apart.
   Prints expected/fracture.txt; the exit status is 1 if a piece is not watertight or volume is lost. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#include <stdio.h>

enum { PIECES = 400, PLANES = 42 };
static const double blow[3] = { 0.5, -0.6, 0.45 };

static double random_number(void)                    /* in [-1, 1) */
{
    static unsigned long long state = 7;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) / 4503599627370496.0 - 1;
}

/* Half-spaces at distance 1 around a spiral over the sphere. */
static void cut_gem(double *planes)
{
    for (int i = 0; i < PLANES; i++) {
        const double z = 1 - (2 * i + 1) / (double)PLANES, r = sqrt(1 - z * z), turn = 2.39996322972865332 * i;
        planes[4 * i] = r * cos(turn), planes[4 * i + 1] = r * sin(turn), planes[4 * i + 2] = z;
        planes[4 * i + 3] = 1;
    }
}

static int farther(const void *a, const void *b)     /* along y, away from the viewer */
{
    return ((const double *)a)[1] < ((const double *)b)[1] ? 1 : -1;
}

static void crack(double *points)
{
    for (int i = 0; i < PIECES;) {
        double *p = points + 3 * i, square = 0;
        for (int k = 0; k < 3; k++) {
            const double x = random_number();
            p[k] = i % 4 == 0 ? 1.1 * x * fabs(x) : blow[k] + 0.6 * x * fabs(x);
            square += p[k] * p[k];
        }
        i += square < 0.98;
    }
    qsort(points, PIECES, 3 * sizeof *points, farther);
}

/* Each edge of the piece is there once each way (its hashes then cancel): it is closed. */
static int is_watertight(const pbw_cells *cells, size_t i)
{
    unsigned long long balance = 0;
    for (size_t f = cells->first[i]; f < cells->first[i + 1]; f++) {
        for (size_t l = cells->loop_first[f], end = cells->loop_first[f + 1]; l < end; l++) {
            const unsigned long long a = cells->loops[l];
            const unsigned long long b = cells->loops[l + 1 < end ? l + 1 : cells->loop_first[f]];
            balance += (a * a * a + 7 * b) * 0x9e3779b97f4a7c15u ^ a;
            balance -= (b * b * b + 7 * a) * 0x9e3779b97f4a7c15u ^ b;
        }
    }
    return balance == 0 && cells->first[i + 1] - cells->first[i] > 3;
}

static void write_pieces(FILE *file, const pbw_cells *cells)
{
    const size_t *loop = cells->loop_first;
    for (size_t i = 0; i < PIECES; i++) {
        fprintf(file, "o piece%zu\n", i);
        for (size_t l = loop[cells->first[i]]; l < loop[cells->first[i + 1]]; l++) {
            const double *x = cells->vertices + 3 * cells->loops[l];
            fprintf(file, "v %.17g %.17g %.17g\n", x[0], x[1], x[2]);
        }
        for (size_t f = cells->first[i]; f < cells->first[i + 1]; f++) {
            for (size_t l = loop[f]; l < loop[f + 1]; l++) {
                size_t same = loop[cells->first[i]];         /* the first corner at this vertex */
                while (cells->loops[same] != cells->loops[l]) {
                    same++;
                }
                fprintf(file, "%s %zu", l > loop[f] ? "" : "f", same + 1);
            }
            fprintf(file, "\n");
        }
    }
}

/* Seen along y, pieces moved apart, the farthest site first: so each piece hides what is behind it. */
static void draw(FILE *file, const pbw_cells *cells)
{
    fprintf(file, "<svg xmlns='http://www.w3.org/2000/svg' viewBox='-320 -320 640 640'>\n");
    for (size_t i = 0; i < PIECES; i++) {
        for (size_t f = cells->first[i]; f < cells->first[i + 1]; f++) {
            const size_t from = cells->loop_first[f], to = cells->loop_first[f + 1];
            double seen = 0, shade;                  /* twice the area on the screen */
            for (size_t l = from; l < to; l++) {
                const double *a = cells->vertices + 3 * cells->loops[l];
                const double *b = cells->vertices + 3 * cells->loops[l + 1 < to ? l + 1 : from];
                seen += a[0] * b[2] - a[2] * b[0];
            }
            shade = 60 + 190 * seen / (2 * cells->areas[f]);
            for (size_t l = from; seen > 0 && l < to; l++) {
                const double *a = cells->vertices + 3 * cells->loops[l], *apart = cells->centroids + 3 * i;
                fprintf(file, "%s %.1f,%.1f", l > from ? "" : "<path stroke='#222' stroke-width='.4' d='M",
                        205 * (a[0] + 0.35 * apart[0]), -205 * (a[2] + 0.35 * apart[2]));
            }
            if (seen > 0) {                          /* the gem's own faces in blue */
                fprintf(file, "z' fill='rgb(%.0f,%.0f,%.0f)'/>\n", shade * (cells->neighbors[f] < PIECES ? 1 : 0.5),
                        shade * 0.85, shade * (cells->neighbors[f] < PIECES ? 0.7 : 1));
            }
        }
    }
    fprintf(file, "</svg>\n");
}

int main(int argc, char **argv)
{
    static double planes[4 * PLANES], points[3 * PIECES];
    double sum = 0, whole = 0;
    size_t closed = 0;
    pbw_mesh mesh = { 0 };
    pbw_cells cells = { 0 };
    pbw_domain domain = { 0 };
    domain.planes = planes;
    domain.plane_count = PLANES;
    cut_gem(planes);
    crack(points);
    if (pbw_triangulate(3, points, NULL, PIECES, NULL, &mesh) != PBW_OK
        || pbw_cells_of(&mesh, &domain, PBW_CELLS_SHAPES, NULL, &cells) != PBW_OK) {
        return 1;
    }
    for (size_t i = 0; i < PIECES; i++) {            /* the gem's own faces are 1 from its middle */
        sum += cells.volumes[i];
        closed += (size_t)is_watertight(&cells, i);
        for (size_t f = cells.first[i]; f < cells.first[i + 1]; f++) {
            whole += cells.neighbors[f] >= PIECES ? cells.areas[f] / 3 : 0;
        }
    }
    printf("%zu of %d pieces are watertight\nvolume: pieces %.9f, gem %.9f\n", closed, PIECES, sum, whole);
    for (int i = 1; i < argc && i < 3; i++) {
        FILE *file = fopen(argv[i], "w");
        file == NULL ? (void)0 : i == 1 ? write_pieces(file, &cells) : draw(file, &cells);
        if (file == NULL || ferror(file) | fclose(file)) {
            perror(argv[i]);
            return 1;
        }
    }
    pbw_cells_free(&cells);
    pbw_free(&mesh);
    return closed != PIECES || !(fabs(sum - whole) < 1e-12 * whole);
}
