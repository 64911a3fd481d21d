/* heat.c: the heat equation on a plate with a round hole, by finite elements on triangles of at least 30 degrees.
   cc -O2 -I. -Iexamples/lib examples/heat.c -o heat -lpthread -lm
   Prints expected/heat.txt; the exit status is 1 if the error does not shrink with the square of the size.
   du/dt = laplace u, with the boundary kept at the values of exp(-2 t) sin x sin y + x y, which solves the equation:
   so the error is known.  Linear elements in space, Crank-Nicolson in time, conjugate gradients for each step. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HOLE = 64, STEPS = 20 };

typedef struct field { const pbw_plane *plane; double *u, *r, *d, *q, *b; unsigned char *fixed; } field;

static double exact(const double *p, double t) { return exp(-2 * t) * sin(p[0]) * sin(p[1]) + p[0] * p[1]; }

/* out = (mass + factor * stiffness) in, triangle by triangle; the rows of the boundary are left 0 if it is fixed. */
static void apply(const field *f, double factor, const double *in, double *out, int keep_boundary)
{
    const pbw_plane *p = f->plane;
    memset(out, 0, p->point_count * sizeof *out);
    for (size_t i = 0; i < p->triangle_count; i++) {
        const pbw_index *v = p->triangles + 3 * i;
        double e[3][2], mean = 0, flux[2] = { 0, 0 };
        for (int k = 0; k < 3; k++) {                /* the edge across from corner k, turned inwards */
            const double *a = p->points + 2 * v[(k + 1) % 3], *b = p->points + 2 * v[(k + 2) % 3];
            e[k][0] = a[1] - b[1];
            e[k][1] = b[0] - a[0];
            mean += in[v[k]];
            flux[0] += in[v[k]] * e[k][0];
            flux[1] += in[v[k]] * e[k][1];
        }
        const double area = (e[0][0] * e[1][1] - e[0][1] * e[1][0]) / 2;
        for (int k = 0; k < 3; k++) {
            out[v[k]] += area / 12 * (mean + in[v[k]])
                       + factor / (4 * area) * (flux[0] * e[k][0] + flux[1] * e[k][1]);
        }
    }
    for (size_t i = 0; i < p->point_count && !keep_boundary; i++) {
        out[i] = f->fixed[i] ? 0 : out[i];
    }
}

static double dot(const field *f, const double *a, const double *b)
{
    double sum = 0;
    for (size_t i = 0; i < f->plane->point_count; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* One step from t to t + dt: the boundary gets its new values, conjugate gradients find the others. */
static void step(field *f, double t, double dt)
{
    const size_t n = f->plane->point_count;
    apply(f, -dt / 2, f->u, f->b, 0);
    for (size_t i = 0; i < n; i++) {
        f->u[i] = f->fixed[i] ? exact(f->plane->points + 2 * i, t + dt) : f->u[i];
    }
    apply(f, dt / 2, f->u, f->q, 0);
    for (size_t i = 0; i < n; i++) {
        f->d[i] = f->r[i] = f->fixed[i] ? 0 : f->b[i] - f->q[i];
    }
    double old = dot(f, f->r, f->r);
    const double goal = 1e-20 * dot(f, f->b, f->b);
    for (int k = 0; k < 1000 && old > goal; k++) {
        apply(f, dt / 2, f->d, f->q, 0);
        const double along = old / dot(f, f->d, f->q);
        for (size_t i = 0; i < n; i++) {
            f->u[i] += along * f->d[i];
            f->r[i] -= along * f->q[i];
        }
        const double next = dot(f, f->r, f->r);
        for (size_t i = 0; i < n; i++) {
            f->d[i] = f->r[i] + next / old * f->d[i];
        }
        old = next;
    }
}

/* The error after STEPS steps, in the mean square over the plate; below 0 after a failure. */
static double solve(double size)
{
    double points[2 * (4 + HOLE)] = { 0, 0, 2, 0, 2, 2, 0, 2 }, error = -1;
    const size_t first[3] = { 0, 4, 4 + HOLE };
    pbw_plane plane = { 0 };
    pbw_plane_options options = { 0 };
    for (int i = 0; i < HOLE; i++) {
        points[8 + 2 * i] = 1 + 0.4 * cos(6.28318530717958648 * i / HOLE);
        points[9 + 2 * i] = 1 + 0.4 * sin(6.28318530717958648 * i / HOLE);
    }
    options.flags = PBW_PLANE_REFINE;
    options.size = size;
    if (pbw_plane_rings(points, first, 2, &options, &plane) != PBW_OK) {
        puts(plane.what);
        return error;
    }
    const size_t n = plane.point_count;
    double *memory = (double *)calloc(6 * n, sizeof *memory);
    if (memory != NULL) {
        field f = { &plane, memory, memory + n, memory + 2 * n, memory + 3 * n, memory + 4 * n,
                    (unsigned char *)(memory + 5 * n) };
        for (size_t i = 0; i < 2 * plane.edge_count; i++) {
            f.fixed[plane.edges[i]] = 1;
        }
        for (size_t i = 0; i < n; i++) {
            f.u[i] = exact(plane.points + 2 * i, 0);
        }
        for (int k = 0; k < STEPS; k++) {
            step(&f, 0.5 * k / STEPS, 0.5 / STEPS);
        }
        for (size_t i = 0; i < n; i++) {
            f.r[i] = f.u[i] - exact(plane.points + 2 * i, 0.5);
        }
        apply(&f, 0, f.r, f.q, 1);
        error = sqrt(dot(&f, f.r, f.q));
        printf("edges up to %-6g error %.1e\n", size, error);
        free(memory);
    }
    pbw_plane_free(&plane);
    return error;
}

int main(void)
{
    const double coarse = solve(0.2), fine = solve(0.1), finest = solve(0.05);
    const double order = log(coarse / finest) / log(4.0);
    printf("order %.0f\n", order);
    return !(fine > 0 && order > 1.7 && order < 2.6);
}
