/* fill.c: heat flows through two materials that share a wall; the conductivity jumps there by a factor of ten.
   cc -O2 -I. -Iexamples/lib examples/fill.c -o fill -lpthread -lm
   Prints expected/fill.txt; the exit status is 1 if the error is not as it must be.
   pbw_fill keeps the triangles of the surface and of the wall, so the jump lies on facets.  Linear elements then have
   (x - 1) / k exactly; of (x - 1) sin y cos z / k the error falls with the square of the size.  Both have the same
   flow of heat on both sides of the wall x = 1. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_FILL_IMPLEMENTATION
#include "pbw_fill.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 16, FACES = 11 * 2 * MOST * MOST };

static const double conductivity[2] = { 1, 10 };     /* left of the wall, right of it */
static double points[9 * FACES];                     /* three a triangle: those at one place count as one */
static pbw_index triangles[3 * FACES];

typedef struct heat { const pbw_tets *t; double *u, *b, *r, *d, *q; unsigned char *fixed; } heat;

static double exact(const double *p, int curved)
{
    return (p[0] - 1) / conductivity[p[0] > 1] * (curved ? sin(p[1]) * cos(p[2]) : 1);
}

/* Two unit cubes side by side, faces in n by n squares: those across x at 0, 1, 2, the others along both cubes. */
static size_t make_surface(int n)
{
    size_t count = 0;
    for (int side = 0; side < 11; side++) {          /* 3 across x, then 2 axes, 2 sides, 2 cubes */
        const int axis = side < 3 ? 0 : 1 + (side - 3) / 4, cube = side < 3 ? 0 : side % 2;
        const double at = side < 3 ? side : (side - 3) / 2 % 2;
        for (int i = 0; i < n * n * 2; i++) {
            static const int corner[2][3][2] = { { { 0, 0 }, { 1, 0 }, { 1, 1 } }, { { 0, 0 }, { 1, 1 }, { 0, 1 } } };
            for (int k = 0; k < 3; k++) {
                double *p = points + 3 * count;
                p[axis] = at;
                p[(axis + 1) % 3] = (double)(i / 2 % n + corner[i % 2][k][0]) / n;
                p[(axis + 2) % 3] = (double)(i / 2 / n + corner[i % 2][k][1]) / n;
                p[0] += cube;
                triangles[count] = (pbw_index)count;
                count++;
            }
        }
    }
    return count / 3;
}

/* q = stiffness d, tetrahedron by tetrahedron, but for fixed points; with b: load as well, of 2 (x - 1) sin y cos z. */
static void apply(const heat *h, const double *d, double *q, double *b)
{
    memset(q, 0, h->t->point_count * sizeof *q);
    for (size_t i = 0; i < h->t->tet_count; i++) {
        const pbw_index *v = h->t->corners + 4 * i;
        double g[4][3], flow[3] = { 0, 0, 0 }, volume6 = 0, load[4], sum = 0;
        for (int k = 0; k < 4; k++) {                /* g: across from corner k, outward, twice the area long */
            const double *a = h->t->points + 3 * v[PBW_FACET_CORNER(k, 0)], *p = h->t->points + 3 * v[k];
            const double *s = h->t->points + 3 * v[PBW_FACET_CORNER(k, 1)];
            const double *t = h->t->points + 3 * v[PBW_FACET_CORNER(k, 2)];
            for (int x = 0, y = 1, z = 2; x < 3; x++, y = (y + 1) % 3, z = (z + 1) % 3) {
                g[k][x] = (s[y] - a[y]) * (t[z] - a[z]) - (s[z] - a[z]) * (t[y] - a[y]);
                flow[x] += d[v[k]] * g[k][x];
                volume6 += k == 0 ? g[k][x] * (a[x] - p[x]) : 0;
            }
            load[k] = 2 * (p[0] - 1) * sin(p[1]) * cos(p[2]);
            sum += load[k];
        }
        for (int k = 0; k < 4; k++) {
            q[v[k]] += conductivity[h->t->regions[i]] / (6 * volume6)
                     * (flow[0] * g[k][0] + flow[1] * g[k][1] + flow[2] * g[k][2]);
            if (b != NULL) {
                b[v[k]] += volume6 / 120 * (sum + load[k]);
            }
        }
    }
    for (size_t i = 0; i < h->t->point_count; i++) {
        q[i] = h->fixed[i] ? 0 : q[i];
    }
}

static double dot(const heat *h, const double *a, const double *b)
{
    double sum = 0;
    for (size_t i = 0; i < h->t->point_count; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* Conjugate gradients.  Returns the largest error at a point. */
static double solve(heat *h, int curved)
{
    const size_t n = h->t->point_count;
    double error = 0;
    memset(h->b, 0, n * sizeof *h->b);
    for (size_t i = 0; i < n; i++) {
        h->u[i] = h->fixed[i] ? exact(h->t->points + 3 * i, curved) : 0;
    }
    apply(h, h->u, h->q, curved ? h->b : NULL);
    for (size_t i = 0; i < n; i++) {
        h->d[i] = h->r[i] = h->fixed[i] ? 0 : h->b[i] - h->q[i];
    }
    double old = dot(h, h->r, h->r);
    for (int k = 0; k < 2000 && old > 1e-28; k++) {
        apply(h, h->d, h->q, NULL);
        const double along = old / dot(h, h->d, h->q), before = old;
        for (size_t i = 0; i < n; i++) {
            h->u[i] += along * h->d[i];
            h->r[i] -= along * h->q[i];
        }
        old = dot(h, h->r, h->r);
        for (size_t i = 0; i < n; i++) {
            h->d[i] = h->r[i] + old / before * h->d[i];
        }
    }
    for (size_t i = 0; i < n; i++) {
        error = fmax(error, fabs(h->u[i] - exact(h->t->points + 3 * i, curved)));
    }
    return error;
}

int main(void)
{
    const double seeds[6] = { 0.4, 0.5, 0.6, 1.4, 0.5, 0.6 };
    const pbw_index regions[2] = { 0, 1 };
    double errors[2] = { 1, 1 };
    int good = 1;
    for (int step = 0; step < 2; step++) {
        const int n = 6 << step;
        const size_t count = make_surface(n);
        const pbw_fill_input input = { points, 3 * count, triangles, count, NULL, NULL, 0, seeds, regions, 2 };
        pbw_fill_options how = { 0 };
        pbw_filled filled = { 0 };
        how.size = 1.0 / n;
        how.improve.target = 15;
        if (pbw_fill(&input, &how, NULL, &filled, NULL) != PBW_OK) {
            return 1;
        }
        const size_t points_of = filled.tets.point_count;
        double *memory = (double *)calloc(6 * points_of, sizeof *memory);
        heat h = { &filled.tets, memory, memory + points_of, memory + 2 * points_of, memory + 3 * points_of,
                   memory + 4 * points_of, (unsigned char *)(memory + 5 * points_of) };
        size_t wall = 0;
        for (size_t i = 0; i < 3 * filled.facet_count; i++) {
            const int outer = filled.sides[2 * (i / 3) + 1] == PBW_NONE;
            h.fixed[filled.facets[i]] |= (unsigned char)outer;
            wall += !outer;
        }
        const double linear = solve(&h, 0);
        errors[step] = solve(&h, 1);
        printf("edges of 1/%d: %zu facets, %zu on the wall; linear %s\n", n, filled.facet_count, wall / 3,
               linear < 1e-9 ? "exact" : "wrong");
        good &= linear < 1e-9;
        free(memory);
        pbw_fill_free(&filled);
    }
    good &= errors[1] < errors[0] / 2.5 && errors[1] < 2e-3;
    printf("half of the size, a quarter of the error, about: %s\n", good ? "yes" : "no");
    return good ? 0 : 1;
}
