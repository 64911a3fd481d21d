/* hello.c: five points in space and their tetrahedra.
   cc -O2 -I. examples/hello.c -o hello -lpthread -lm
   Prints one line a tetrahedron: its corners and its neighbours across from them, as in expected/hello.txt. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>

int main(void)
{
    const double points[] = { 0,0,0,  1,0,0,  0,1,0,  0,0,1,  1,1,1 };
    pbw_mesh mesh = { 0 };
    pbw_status status = pbw_triangulate(3, points, NULL, 5, NULL, &mesh);
    if (status != PBW_OK) {
        printf("%s\n", pbw_status_string(status));
        return 1;
    }
    for (size_t i = 0; i < mesh.simplex_count; i++) {
        const pbw_index *c = mesh.simplices + 4 * i, *n = mesh.neighbors + 4 * i;       /* -1 is PBW_NONE: outside */
        printf("%u %u %u %u   %d %d %d %d\n", c[0], c[1], c[2], c[3], (int)n[0], (int)n[1], (int)n[2], (int)n[3]);
    }
    pbw_free(&mesh);
    return 0;
}
