/* hull.c: the convex hull of points in space: the facets of the Delaunay tetrahedra with nothing behind them.
   cc -O2 -I. examples/hull.c -o hull -lpthread -lm
   hull hull.obj also writes it as an OBJ model.  Prints its size as in expected/hull.txt.
   Points inside a flat face of the hull are among its vertices, which makes it a mesh of the whole surface. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { COUNT = 20000 };

/* All hull facets, three point ids each, counter-clockwise seen from outside; NULL if out of memory. */
static pbw_index *hull_of(const pbw_mesh *mesh, size_t *facets)
{
    pbw_index *hull = NULL;
    for (int pass = 0; pass < 2; pass++) {                           /* count, then fill */
        *facets = 0;
        for (size_t i = 0; i < 4 * mesh->simplex_count; i++) {
            if (mesh->neighbors[i] == PBW_NONE) {
                for (int k = 0; pass == 1 && k < 3; k++) {
                    hull[3 * *facets + (size_t)k] = mesh->simplices[i - i % 4 + PBW_FACET_CORNER(i % 4, k)];
                }
                ++*facets;
            }
        }
        if (pass == 0 && (hull = (pbw_index *)malloc(3 * *facets * sizeof *hull)) == NULL) {
            break;
        }
    }
    return hull;
}

int main(int argc, char **argv)
{
    static double points[3 * COUNT];
    static char on_hull[COUNT];
    unsigned long long state = 1;
    pbw_mesh mesh = { 0 };
    pbw_status status;
    pbw_index *hull;
    size_t facets, vertices = 0;
    double area = 0, volume = 0;
    for (int i = 0; i < 3 * COUNT; i++) {                            /* a cube of side 2, cut off at x + y + z = 1 */
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = (double)(state >> 11) / 4503599627370496.0 - 1;
        if (i % 3 == 2 && points[i - 2] + points[i - 1] + points[i] > 1) {
            i -= 3;
        }
    }
    status = pbw_triangulate(3, points, NULL, COUNT, NULL, &mesh);
    hull = status == PBW_OK ? hull_of(&mesh, &facets) : NULL;
    if (hull == NULL) {
        printf("%s\n", pbw_status_string(status == PBW_OK ? PBW_ERROR_MEMORY : status));
        return 1;
    }
    for (size_t i = 0; i < facets; i++) {
        const pbw_index *h = hull + 3 * i;
        const double *a = points + 3 * h[0], *b = points + 3 * h[1], *c = points + 3 * h[2];
        const double u[3] = { b[0] - a[0], b[1] - a[1], b[2] - a[2] };
        const double v[3] = { c[0] - a[0], c[1] - a[1], c[2] - a[2] };
        const double n[3] = { u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0] };
        area += sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
        volume += (n[0] * a[0] + n[1] * a[1] + n[2] * a[2]) / 6;
        for (int k = 0; k < 3; k++) {
            vertices += !on_hull[h[k]];
            on_hull[h[k]] = 1;
        }
    }
    printf("%zu facets, %zu vertices; facets = 2 vertices - 4: %s\n", facets, vertices,
           facets == 2 * vertices - 4 ? "yes" : "no");
    printf("area %.6f, volume %.6f (of the body itself: 21.4641 and 6.6667)\n", area, volume);
    if (argc > 1) {
        FILE *file = fopen(argv[1], "w");
        for (int i = 0; file != NULL && i < COUNT; i++) {
            fprintf(file, "v %.17g %.17g %.17g\n", points[3 * i], points[3 * i + 1], points[3 * i + 2]);
        }
        for (size_t i = 0; file != NULL && i < facets; i++) {
            fprintf(file, "f %u %u %u\n", hull[3 * i] + 1, hull[3 * i + 1] + 1, hull[3 * i + 2] + 1);
        }
        if (file == NULL || ferror(file) | fclose(file)) {
            perror(argv[1]);
            return 1;
        }
    }
    free(hull);
    pbw_free(&mesh);
    return 0;
}
