/* nearest_graph.c: the nearest-neighbour graph of a million points, and how it falls into pieces.
   cc -O2 -I. -Iexamples/lib examples/nearest_graph.c -o nearest_graph -lpthread
   Each point asks for its two nearest: itself and the other.  Each piece has just one pair that is mutual, so there
   are as many pieces as such pairs: 0.3108 a point, if random in the plane.  Prints expected/nearest_graph.txt. */
#define PBW_IMPLEMENTATION
#define PBW_QUERY_IMPLEMENTATION
#include "pbw_query.h"
#include <stdio.h>
#include <stdlib.h>

enum { COUNT = 1000000 };

/* The root of a point's piece; the way there is shortened. */
static pbw_index root(pbw_index *parent, pbw_index i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

int main(void)
{
    double *points = (double *)malloc(2 * COUNT * sizeof *points);
    pbw_index *two = (pbw_index *)malloc(2 * COUNT * sizeof *two);
    pbw_index *parent = (pbw_index *)malloc(COUNT * sizeof *parent);
    unsigned long long state = 1;
    pbw_options options = { 0 };
    pbw_mesh mesh = { 0 };
    pbw_status status;
    size_t pieces = COUNT, mutual = 0;
    if (points == NULL || two == NULL || parent == NULL) {
        return 1;
    }
    for (int i = 0; i < 2 * COUNT; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = (double)(state >> 11) / 9007199254740992.0;
    }
    options.flags = PBW_CURVE_ORDER;               /* the mesh numbers its points along a curve: queries are faster */
    status = pbw_triangulate(2, points, NULL, COUNT, &options, &mesh);
    options.flags = 0;
    if (status == PBW_OK) {
        status = pbw_nearest(&mesh, NULL, mesh.points, COUNT, 2, &options, two, NULL);
    }
    if (status != PBW_OK) {
        printf("%s\n", pbw_status_string(status));
        return 1;
    }
    for (pbw_index i = 0; i < COUNT; i++) {
        parent[i] = i;
    }
    for (pbw_index i = 0; i < COUNT; i++) {
        pbw_index other = two[2 * i] == i ? two[2 * i + 1] : two[2 * i], a = root(parent, i), b = root(parent, other);
        mutual += (two[2 * other] == other ? two[2 * other + 1] : two[2 * other]) == i;
        pieces -= a != b;
        parent[a] = b;
    }
    printf("%d points, %zu pieces, %zu mutual pairs\n", COUNT, pieces, mutual / 2);
    printf("%.4f pieces a point\n", (double)pieces / COUNT);
    pbw_free(&mesh);
    free(points);
    free(two);
    free(parent);
    return 0;
}
