/* periodic.c: a foam without walls: power cells of points in a box that repeats, in the plane.
   cc -O2 -I. -Iexamples/lib examples/periodic.c -o periodic -lpthread -lm
   periodic foam.svg also draws it, two boxes each way, bubbles darker the more neighbours they have.
   Prints expected/periodic.txt; the exit status is 1 if area is lost, or a wall is not seen from both sides.
   A neighbour comes as a point and a shift: it is that point moved by so many boxes along each axis.  In a foam
   without an edge bubbles have six neighbours in the mean (Euler). */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#include <math.h>
#include <stdio.h>

enum { COUNT = 120, MOST = 24 };

static double random_number(void)                    /* in [0, 1) */
{
    static unsigned long long state = 3;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) / 9007199254740992.0;
}

/* Is facet f of cell i also one of its neighbour, with the opposite shift and the same length? */
static int is_mutual(const pbw_cells *cells, size_t i, size_t f)
{
    const size_t j = cells->neighbors[f];
    for (size_t g = cells->first[j]; g < cells->first[j + 1]; g++) {
        if (cells->neighbors[g] == i && cells->shifts[2 * g] == -cells->shifts[2 * f]
            && cells->shifts[2 * g + 1] == -cells->shifts[2 * f + 1]) {
            return fabs(cells->areas[g] - cells->areas[f]) < 1e-12;
        }
    }
    return 0;
}

static int draw(const pbw_cells *cells, const char *path)
{
    FILE *file = fopen(path, "w");
    if (file == NULL) {
        perror(path);
        return 0;
    }
    fprintf(file, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 800 800\">\n"
            "<g stroke=\"#124\" stroke-width=\"2\" stroke-linejoin=\"round\">\n");
    for (size_t i = 0; i < 9 * COUNT; i++) {         /* 3 x 3 boxes, of which the middle is at 200..600 */
        const size_t cell = i / 9, facets = cells->first[cell + 1] - cells->first[cell];
        fprintf(file, "<path fill=\"hsl(205,55%%,%zu%%)\" d=\"", facets < 10 ? 110 - 9 * facets : 20);
        for (size_t f = cells->first[cell]; f < cells->first[cell + 1]; f++) {
            const double *x = cells->vertices + 2 * cells->loops[cells->loop_first[f]];
            fprintf(file, "%s%.2f,%.2f", f == cells->first[cell] ? "M" : " ", 400 * (x[0] + (double)(i % 3)) - 200,
                    400 * (x[1] + (double)(i / 3 % 3)) - 200);
        }
        fprintf(file, "Z\"/>\n");
    }
    fprintf(file, "</g>\n<path d=\"M200,200h400v400h-400Z\" fill=\"none\" stroke=\"#c30\" stroke-width=\"3\"/>\n"
            "</svg>\n");
    if (ferror(file) | fclose(file)) {
        perror(path);
        return 0;
    }
    return 1;
}

int main(int argc, char **argv)
{
    static const double box[4] = { 0, 0, 1, 1 };
    static double points[2 * COUNT], weights[COUNT];
    size_t bubbles[MOST] = { 0 }, mutual = 0, through = 0, cells_left = 0;
    double sum = 0;
    pbw_domain domain = { 0 };
    pbw_cells cells = { 0 };
    int good;
    domain.box = box;
    domain.periodic = 3;                             /* x and y */
    for (int i = 0; i < COUNT; i++) {
        points[2 * i] = random_number();
        points[2 * i + 1] = random_number();
        weights[i] = 0.006 * random_number();
    }
    for (int step = 0; step < 20; step++) {          /* towards the centroids, so that bubbles are round */
        if (pbw_cells_periodic(2, points, weights, COUNT, &domain, PBW_CELLS_SHAPES, NULL, &cells) != PBW_OK) {
            return 1;
        }
        if (step < 19) {
            for (int i = 0; i < 2 * COUNT; i++) {
                points[i] = cells.centroids[i];
            }
            pbw_cells_free(&cells);
        }
    }
    for (size_t i = 0; i < COUNT; i++) {
        const size_t facets = cells.first[i + 1] - cells.first[i];
        sum += cells.volumes[i];
        cells_left += facets > 0;
        bubbles[facets < MOST ? facets : MOST - 1]++;
        for (size_t f = cells.first[i]; f < cells.first[i + 1]; f++) {
            mutual += (size_t)is_mutual(&cells, i, f);
            through += cells.shifts[2 * f] != 0 || cells.shifts[2 * f + 1] != 0;
        }
    }
    good = mutual == cells.facet_count && fabs(sum - 1) < 1e-12;
    printf("%zu bubbles, %zu walls, %zu of them across the box's sides\n", cells_left, cells.facet_count / 2,
           through / 2);
    for (size_t k = 1; k < MOST; k++) {
        if (bubbles[k] > 0) {
            printf("%3zu with %zu walls\n", bubbles[k], k);
        }
    }
    printf("mean: %.2f walls; area %.9f\n", (double)cells.facet_count / (double)cells_left, sum);
    good &= argc < 2 || draw(&cells, argv[1]);
    pbw_cells_free(&cells);
    return !good;
}
