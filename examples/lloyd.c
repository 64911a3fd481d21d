/* lloyd.c: well-spaced points: each moves to the centroid of its Voronoi cell, again and again.
   cc -O2 -I. -Iexamples/lib examples/lloyd.c -o lloyd -lpthread -lm
   lloyd [POINTS [STEPS]].  Prints expected/lloyd.txt; the exit status is 1 if a step does not lower the energy.
   The energy is the integral of the squared distance to the nearest point.  Both parts of a step lower it: new cells
   give each place its nearest point, and of all points a cell's centroid is the nearest to it in the mean (Lloyd
   1982, "Least squares quantization in PCM"; Du, Faber and Gunzburger 1999, "Centroidal Voronoi tessellations"). */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* The integral of |x - site|^2 over a cell: its edges' triangles with the site. */
static double energy_of(const pbw_cells *cells, const double *site, size_t cell)
{
    double energy = 0;
    for (size_t f = cells->first[cell]; f < cells->first[cell + 1]; f++) {
        const double *a = cells->vertices + 2 * cells->loops[cells->loop_first[f]];
        const double *b = cells->vertices + 2 * cells->loops[cells->loop_first[f] + 1];
        const double u[2] = { a[0] - site[0], a[1] - site[1] }, v[2] = { b[0] - site[0], b[1] - site[1] };
        const double uu = u[0] * u[0] + u[1] * u[1], vv = v[0] * v[0] + v[1] * v[1], uv = u[0] * v[0] + u[1] * v[1];
        energy += (u[0] * v[1] - u[1] * v[0]) * (uu + uv + vv) / 12;
    }
    return energy;
}

int main(int argc, char **argv)
{
    static const double box[4] = { 0, 0, 1, 1 };
    const size_t count = argc > 1 ? strtoul(argv[1], NULL, 10) : 1000;
    const int steps = argc > 2 ? atoi(argv[2]) : 50;
    double *points = (double *)malloc(2 * count * sizeof *points), before = HUGE_VAL;
    unsigned long long state = 1;
    pbw_domain domain = { 0 };
    domain.box = box;
    if (points == NULL) {
        return 1;
    }
    for (size_t i = 0; i < 2 * count; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = (double)(state >> 11) / 9007199254740992.0;
    }
    for (int step = 0; step <= steps; step++) {
        pbw_mesh mesh = { 0 };
        pbw_cells cells = { 0 };
        double energy = 0;
        pbw_status status = pbw_triangulate(2, points, NULL, count, NULL, &mesh);
        if (status == PBW_OK) {
            status = pbw_cells_of(&mesh, &domain, PBW_CELLS_SHAPES, NULL, &cells);
        }
        if (status != PBW_OK) {
            printf("%s\n", pbw_status_string(status));
            return 1;
        }
        for (size_t i = 0; i < count; i++) {
            energy += energy_of(&cells, points + 2 * i, i);
        }
        for (size_t i = 0; i < 2 * count; i++) {
            points[i] = cells.centroids[i];
        }
        if (step % 10 == 0) {
            printf("step %2d: energy * points = %.4f\n", step, energy * (double)count);
        }
        if (energy >= before) {
            printf("step %d: the energy rose\n", step);
            return 1;
        }
        before = energy;
        pbw_cells_free(&cells);
        pbw_free(&mesh);
    }
    printf("regular hexagons would have %.4f\n", 5 / (18 * sqrt(3.0)));
    free(points);
    return 0;
}
