/* disks.c: the Voronoi diagram of disks, with curved edges: each place belongs to the disk with the nearest boundary.
   cc -O2 -I. -Iexamples/lib examples/disks.c -o disks -lpthread -lm
   Prints expected/disks.txt; the exit status is 1 if an edge is off by more than the stated error.
   Approximated by the Voronoi cells of points on the circles: a disk has the cells of its points.  From a place
   outside a disk of radius r the nearest of its n points is farther than its circle by at most half the step,
   pi r / n, as the circle's nearest place has a point that close.  So on an edge of the approximation the two
   distances differ by at most the larger of both errors. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { DISKS = 6 };
static const double disks[DISKS][3] = {              /* x, y, radius */
    { 0.2, 0.25, 0.15 }, { 0.6, 0.2, 0.08 }, { 0.8, 0.7, 0.19 }, { 0.3, 0.8, 0.1 }, { 0.5, 0.5, 0.03 },
    { 0.9, 0.1, 0.05 } };

static double distance_to(int disk, const double *x)
{
    const double u = x[0] - disks[disk][0], v = x[1] - disks[disk][1];
    return sqrt(u * u + v * v) - disks[disk][2];
}

/* The largest difference of distances at the corners of edges between two disks; the disks' areas. */
static pbw_status approximate(int each, double *areas, double *error)
{
    static const double box[4] = { 0, 0, 1, 1 };
    const size_t count = (size_t)each * DISKS;
    double *points = (double *)malloc(2 * count * sizeof *points);
    pbw_mesh mesh = { 0 };
    pbw_cells cells = { 0 };
    pbw_domain domain = { 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    domain.box = box;
    *error = 0;
    for (size_t i = 0; points != NULL && i < count; i++) {
        const double *disk = disks[i / (size_t)each];
        const double angle = 6.28318530717958648 * (double)(i % (size_t)each) / each;
        points[2 * i] = disk[0] + disk[2] * cos(angle);
        points[2 * i + 1] = disk[1] + disk[2] * sin(angle);
    }
    if (points != NULL) {
        status = pbw_triangulate(2, points, NULL, count, NULL, &mesh);
    }
    if (status == PBW_OK) {
        status = pbw_cells_of(&mesh, &domain, PBW_CELLS_SHAPES, NULL, &cells);
    }
    for (size_t i = 0; status == PBW_OK && i < count; i++) {
        const int a = (int)(i / (size_t)each);
        areas[a] += cells.volumes[i];
        for (size_t f = cells.first[i]; f < cells.first[i + 1]; f++) {
            const int b = cells.neighbors[f] < count ? (int)(cells.neighbors[f] / (size_t)each) : a;
            for (size_t l = cells.loop_first[f]; a != b && l < cells.loop_first[f + 1]; l++) {
                const double *x = cells.vertices + 2 * cells.loops[l];
                *error = fmax(*error, fabs(distance_to(a, x) - distance_to(b, x)));
            }
        }
    }
    pbw_cells_free(&cells);
    pbw_free(&mesh);
    free(points);
    return status;
}

int main(void)
{
    int wrong = 0;
    for (int each = 16; each <= 1024; each *= 8) {
        double areas[DISKS] = { 0 }, error, bound = 0, sum = 0;
        const pbw_status status = approximate(each, areas, &error);
        if (status != PBW_OK) {
            printf("%s\n", pbw_status_string(status));
            return 1;
        }
        printf("%4d points a disk: areas", each);
        for (int i = 0; i < DISKS; i++) {
            bound = fmax(bound, 3.14159265358979324 * disks[i][2] / each);
            sum += areas[i];
            printf(" %.4f", areas[i]);
        }
        printf(", error %.6f, at most %.6f\n", error, bound);
        wrong |= error > bound || !(fabs(sum - 1) < 1e-12);
    }
    return wrong;
}
