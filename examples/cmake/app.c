/* app.c: a program of two source files: pbw.c has the implementation, this one only calls it.  See CMakeLists.txt. */
#include "pbw.h"
#include <stdio.h>

int main(void)
{
    const double points[] = { 0,0,  1,0,  1,1,  0,1,  0.5,0.5 };
    pbw_mesh mesh = { 0 };
    pbw_status status = pbw_triangulate(2, points, NULL, 5, NULL, &mesh);
    printf("%s: %zu triangles\n", pbw_status_string(status), mesh.simplex_count);
    pbw_free(&mesh);
    return status != PBW_OK;
}
