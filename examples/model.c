/* model.c: a closed surface to try things on: a rope of three strands, tied into a trefoil knot.
   cc -O2 -I. examples/model.c -o model -lm;  ./model knot.obj [detail]
   Writes knot.obj: 32400 points, 64800 triangles (for detail 1). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double turn = 6.283185307179586;

/* The point at parameter t along the rope, at angle a around it.  The axis is the (2,3) torus knot; it lies on a
   torus, whose normal and the tangent give a frame that closes after one round. */
static void rope(double t, double a, double out[3])
{
    double big = 2 + 0.98 * cos(3 * t), u[3], n[3], v[3], b[3], length, radius;
    int k;
    u[0] = -2 * big * sin(2 * t) - 2.94 * sin(3 * t) * cos(2 * t);       /* d/dt of the axis */
    u[1] = 2 * big * cos(2 * t) - 2.94 * sin(3 * t) * sin(2 * t);
    u[2] = 3.3 * cos(3 * t);
    n[0] = cos(3 * t) * cos(2 * t);
    n[1] = cos(3 * t) * sin(2 * t);
    n[2] = sin(3 * t);
    b[0] = u[1] * n[2] - u[2] * n[1];
    b[1] = u[2] * n[0] - u[0] * n[2];
    b[2] = u[0] * n[1] - u[1] * n[0];
    length = sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
    for (k = 0; k < 3; k++) {
        b[k] /= length;
    }
    v[0] = b[1] * u[2] - b[2] * u[1];
    v[1] = b[2] * u[0] - b[0] * u[2];
    v[2] = b[0] * u[1] - b[1] * u[0];
    length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    radius = 0.47 + 0.065 * cos(3 * a + 14 * t) + 0.012 * cos(36 * t) * cos(6 * a);
    out[0] = big * cos(2 * t);
    out[1] = big * sin(2 * t);
    out[2] = 1.1 * sin(3 * t);
    for (k = 0; k < 3; k++) {
        out[k] += radius * (cos(a) * v[k] / length + sin(a) * b[k]);
    }
}

/* Rings of points around the rope, every second one turned by half a step, so that the triangles between them are
   nearly regular. */
int main(int argc, char **argv)
{
    double detail = argc > 2 ? atof(argv[2]) : 1, p[3];
    long rings = 2 * lround(300 * sqrt(detail)), sides = lround(54 * sqrt(detail)), i, j;
    FILE *file = argc > 1 ? fopen(argv[1], "w") : NULL;
    if (file == NULL || !(detail > 0.01 && detail < 1000)) {
        fprintf(stderr, "usage: model file.obj [detail, 1 = 64800 triangles]\n");
        return 2;
    }
    for (i = 0; i < rings; i++) {
        for (j = 0; j < sides; j++) {
            rope(turn * (double)i / (double)rings, turn * ((double)j + 0.5 * (double)(i & 1)) / (double)sides, p);
            fprintf(file, "v %.9g %.9g %.9g\n", p[0], p[1], p[2]);
        }
    }
    for (i = 0; i < rings; i++) {
        for (j = 0; j < sides; j++) {
            long a = i * sides + j, b = i * sides + (j + 1) % sides, next = (i + 1) % rings * sides;
            long c = next + (j + (i & 1)) % sides, d = next + (j + 1 + (i & 1)) % sides;
            fprintf(file, "f %ld %ld %ld\nf %ld %ld %ld\n", a + 1, b + 1, c + 1, b + 1, d + 1, c + 1);
        }
    }
    if (ferror(file) | fclose(file)) {
        perror(argv[1]);
        return 1;
    }
    printf("%s: %ld points, %ld triangles\n", argv[1], rings * sides, 2 * rings * sides);
    return 0;
}
