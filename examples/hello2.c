/* hello2.c: circles in the plane as weighted points (weight = radius squared); one is a duplicate, one is hidden.
   cc -O2 -I. examples/hello2.c -o hello2 -lpthread -lm
   Prints the triangles and what became of each point, as in expected/hello2.txt. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>

int main(void)
{
    enum { COUNT = 7 };
    const double points[2 * COUNT] = { 0,0,  4,0,  4,4,  0,4,  2,2,  2.5,2,  4,0 };
    const double radii[COUNT] = { 1, 1, 1, 1, 1.5, 0.25, 0.5 };
    double weights[COUNT];
    pbw_mesh mesh = { 0 };
    pbw_status status;
    for (int i = 0; i < COUNT; i++) {
        weights[i] = radii[i] * radii[i];
    }
    status = pbw_triangulate(2, points, weights, COUNT, NULL, &mesh);
    if (status != PBW_OK) {
        printf("%s\n", pbw_status_string(status));
        return 1;
    }
    for (size_t i = 0; i < mesh.simplex_count; i++) {
        const pbw_index *corner = mesh.simplices + 3 * i;
        printf("triangle %u %u %u\n", corner[0], corner[1], corner[2]);
    }
    for (pbw_index i = 0; i < COUNT; i++) {
        if (mesh.canonical[i] != i) {
            printf("point %u duplicates point %u\n", i, mesh.canonical[i]);
        } else if (mesh.incident[i] == PBW_NONE) {
            printf("point %u is hidden: no part of the plane has the least power distance to it\n", i);
        } else {
            printf("point %u is a vertex\n", i);
        }
    }
    pbw_free(&mesh);
    return 0;
}
