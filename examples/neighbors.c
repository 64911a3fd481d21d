/* neighbors.c: the nearest neighbour of every point, found among its Delaunay neighbours.
   cc -O2 -I. examples/neighbors.c -o neighbors -lpthread -lm
   The ball around a point that reaches to its nearest neighbour is empty, so the two share a Delaunay edge: O(n)
   after the triangulation, instead of O(n^2).  Prints expected/neighbors.txt; the limit of the share of mutual pairs
   is 16/27 = 0.5926 for random points in space. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>
#include <stdlib.h>

enum { COUNT = 100000, CHECKED = 200 };

static double distance2(const double *p, const double *q)
{
    double x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
    return x * x + y * y + z * z;
}

/* j becomes the neighbour of i if it is nearer, or as near with a lower index. */
static void improve(const double *points, pbw_index *nearest, pbw_index i, pbw_index j)
{
    if (nearest[i] != PBW_NONE) {
        double old = distance2(points + 3 * i, points + 3 * nearest[i]);
        double other = distance2(points + 3 * i, points + 3 * j);
        if (other > old || (other >= old && j >= nearest[i])) {
            return;
        }
    }
    nearest[i] = j;
}

int main(void)
{
    double *points = (double *)malloc(3 * COUNT * sizeof *points);
    pbw_index *nearest = (pbw_index *)malloc(COUNT * sizeof *nearest);
    unsigned long long state = 1;
    pbw_mesh mesh = { 0 };
    pbw_status status;
    size_t mutual = 0;
    int right = 0;
    if (points == NULL || nearest == NULL) {
        return 1;
    }
    for (int i = 0; i < 3 * COUNT; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = (double)(state >> 11) / 9007199254740992.0;
    }
    points[3] = points[0], points[4] = points[1], points[5] = points[2];        /* point 1 duplicates point 0 */
    status = pbw_triangulate(3, points, NULL, COUNT, NULL, &mesh);
    if (status != PBW_OK) {
        printf("%s\n", pbw_status_string(status));
        return 1;
    }
    for (pbw_index i = 0; i < COUNT; i++) {
        nearest[i] = PBW_NONE;
    }
    for (size_t i = 0; i < mesh.simplex_count; i++) {
        const pbw_index *c = mesh.simplices + 4 * i;
        for (int a = 0; a < 4; a++) {
            for (int b = 0; b < 4; b++) {
                if (a != b) {
                    improve(points, nearest, c[a], c[b]);
                }
            }
        }
    }
    for (pbw_index i = 0; i < COUNT; i++) {                                     /* at distance 0, and no vertices */
        if (mesh.canonical[i] != i) {
            improve(points, nearest, i, mesh.canonical[i]);
            improve(points, nearest, mesh.canonical[i], i);
        }
    }
    for (pbw_index i = 0; i < COUNT; i++) {
        mutual += nearest[nearest[i]] == i;
    }
    for (pbw_index i = 0; i < CHECKED; i++) {
        pbw_index best = PBW_NONE;
        double least = 0;
        for (pbw_index j = 0; j < COUNT; j++) {
            if (j != i) {
                double d = distance2(points + 3 * i, points + 3 * j);
                best = best == PBW_NONE || d < least ? j : best;
                least = best == j ? d : least;
            }
        }
        right += best == nearest[i];
    }
    printf("%d points, %zu tetrahedra\n", COUNT, mesh.simplex_count);
    printf("nearest of 0: %u, of 1: %u, of 2: %u\n", nearest[0], nearest[1], nearest[2]);
    printf("pairs that are each other's nearest: %.4f of the points\n", (double)mutual / COUNT);
    printf("compared with all others: %d of %d right\n", right, CHECKED);
    pbw_free(&mesh);
    free(nearest);
    free(points);
    return 0;
}
