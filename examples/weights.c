/* weights.c: a ball that grows among 2000 others until it has swallowed its neighbours.
   cc -O2 -I. examples/weights.c -o weights -lpthread -lm
   A point with weight radius^2 is a ball, and its cell is where |x - p|^2 - weight is less than for all others.  A
   point whose cell is empty is hidden: mesh.incident is PBW_NONE.  Prints the counts of expected/weights.txt. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>
#include <string.h>

enum { COUNT = 2000 };

/* A hidden point is in conflict with no tetrahedron: its lifted point is above all of the lower hull. */
static int conflicts(const pbw_mesh *mesh, pbw_index p)
{
    int count = 0;
    for (size_t i = 0; i < mesh->simplex_count; i++) {
        const pbw_index *c = mesh->simplices + 4 * i;
        const double w[5] = { mesh->weights[c[0]], mesh->weights[c[1]], mesh->weights[c[2]], mesh->weights[c[3]],
                              mesh->weights[p] };
        count += pbw_power3(mesh->points + 3 * c[0], mesh->points + 3 * c[1], mesh->points + 3 * c[2],
                            mesh->points + 3 * c[3], mesh->points + 3 * p, w) > 0;
    }
    return count;
}

int main(void)
{
    static double points[3 * COUNT], weights[COUNT];
    unsigned long long state = 1;
    pbw_mesh mesh = { 0 }, shifted = { 0 };
    pbw_status status;
    for (int i = 0; i < 3 * COUNT; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = i < 3 ? 0.5 : (double)(state >> 11) / 9007199254740992.0;        /* point 0 is in the middle */
    }
    for (int step = 0; step <= 8; step++) {
        double radius = step / 16.0;
        pbw_index first = PBW_NONE;
        weights[0] = radius * radius;
        status = pbw_triangulate(3, points, weights, COUNT, NULL, &mesh);
        if (status != PBW_OK) {
            printf("%s\n", pbw_status_string(status));
            return 1;
        }
        for (pbw_index i = 0; i < COUNT && first == PBW_NONE; i++) {
            if (mesh.incident[i] == PBW_NONE && mesh.canonical[i] == i) {
                first = i;
            }
        }
        printf("radius %.4f: %5zu tetrahedra, %4zu points hidden", radius, mesh.simplex_count, mesh.hidden_count);
        if (first != PBW_NONE) {
            printf(", the first is %u, which conflicts with %d tetrahedra", first, conflicts(&mesh, first));
        }
        printf("\n");
        if (step < 8) {
            pbw_free(&mesh);
        }
    }
    for (int i = 0; i < COUNT; i++) {
        weights[i] += 4;               /* only differences of weights count */
    }
    status = pbw_triangulate(3, points, weights, COUNT, NULL, &shifted);
    printf("with 4 added to all weights: %s\n", status == PBW_OK && shifted.simplex_count == mesh.simplex_count &&
           memcmp(shifted.simplices, mesh.simplices, 4 * sizeof(pbw_index) * mesh.simplex_count) == 0 ? "the same" :
           "not the same");
    pbw_free(&shifted);
    pbw_free(&mesh);
    return 0;
}
