/* stuffing.c: tetrahedra for an implicit function without a triangulation, at several sizes: angles stay good,
   whatever the function.
   cc -O2 -I. -Iexamples/lib examples/stuffing.c -o stuffing -lpthread -lm;  ./stuffing */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#include "pbw_stuffing.h"
#include <stdio.h>

static double gyroid(const double p[3])    /* in a ball; above zero inside */
{
    const double x = 6 * p[0], y = 6 * p[1], z = 6 * p[2];
    return fmin(0.5 - fabs(sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x)),
                0.9 - sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]));
}

int main(void)
{
    int n, bad = 0;
    for (n = 12; n <= 48; n *= 2) {
        pbwst_mesh made;
        pbw_tets mesh = { 0 };
        pbw_quality q;
        if (pbwst_make(n, -1.1, 1.1, gyroid, NULL, &made) != PBW_OK) {
            return 1;
        }
        mesh.points = made.x[0];
        mesh.corners = made.corners;
        mesh.tet_count = made.tets;
        pbw_tets_quality(&mesh, NULL, &q);
        printf("%d nodes an axis: %zu tetrahedra, dihedral angles %.1f to %.1f degrees, volume %.3f\n", n, made.tets,
               q.least, q.largest, q.volume);
        bad += q.least < 10.7 || q.largest > 164.8;
        pbwst_free(&made);
    }
    return bad > 0;
}
