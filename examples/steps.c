/* steps.c: how a point gets into a Delaunay triangulation: walk, cavity and star.
   cc -O2 -I. examples/steps.c -o steps -lpthread -lm
   steps steps.svg also draws it, three pictures in one file.  Prints expected/steps.txt. */
#include "steps.h"

static void one_point(int which)
{
    const double *q = points[which];
    int star = 0;
    locate(q);
    picture("1  Walk: across edges that have the point beyond");
    for (int i = 0; i < walked; i++) {
        triangle(walk[i], "#0072b2", 0.15 + 0.5 * i / walked);
    }
    circle(q, 5, "#d55e00", "#fff");
    picture("2  Cavity: triangles whose circles hold the point");
    for (int i = 0; i < carved; i++) {
        const double *a = corner(cavity[i], 0), *b = corner(cavity[i], 1), *c = corner(cavity[i], 2);
        double u = b[0] - a[0], v = b[1] - a[1], x = c[0] - a[0], y = c[1] - a[1], area = 2 * (u * y - v * x);
        double r = u * u + v * v, s = x * x + y * y, dx = (y * r - v * s) / area, dy = (u * s - x * r) / area;
        triangle(cavity[i], "#e69f00", 0.6);
        circle((double[2]) { a[0] + dx, a[1] + dy }, sqrt(dx * dx + dy * dy), "none", "#d55e00");
    }
    circle(q, 5, "#d55e00", "#fff");
    inserted[which] = 1;
    triangulate();
    picture("3  Star: the cavity filled from the point");
    for (pbw_index i = 0; i < 3 * mesh.simplex_count; i++) {
        if (mesh.simplices[i] == (pbw_index)which) {
            triangle(i / 3, "#009e73", 0.4);
            star++;
        }
    }
    circle(q, 5, "#d55e00", "#fff");
    printf("one point: a walk through %d triangles, a cavity of %d, a star of %d\n", walked, carved, star);
}

int main(int argc, char **argv)
{
    begin_pictures(argc, argv);
    scatter();
    begin_with(16);
    one_point(540);
    return end_pictures(argc, argv);
}
