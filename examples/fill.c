/* fill.c: heat flows through two materials that share a wall; the conductivity jumps there by a factor of ten.
   cc -O2 -I. -Iexamples/lib examples/fill.c -o fill -lpthread -lm
   Prints expected/fill.txt; the exit status is 1 if the error is not as it must be.
   pbw_fill keeps the triangles of the surface and of the wall, x = 1, so the jump lies on facets.  Linear elements
   then have (x - 1) / k exactly; of (x - 1) sin y cos z / k the error falls with the square of the size. */
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

enum { MOST = 12, FACES = 11 * 2 * MOST * MOST };

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
    static const int corner[6][2] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 0 }, { 1, 1 }, { 0, 1 } };
    size_t count = 0;
    for (int side = 0; side < 11; side++) {          /* 3 across x, then 2 axes, 2 sides, 2 cubes */
        const int axis = side < 3 ? 0 : 1 + (side - 3) / 4, cube = side < 3 ? 0 : side % 2;
        for (int i = 0; i < 6 * n * n; i++, count++) {
            double *p = points + 3 * count;
            p[axis] = side < 3 ? side : (side - 3) / 2 % 2;
            p[(axis + 1) % 3] = (double)(i / 6 % n + corner[i % 6][0]) / n;
            p[(axis + 2) % 3] = (double)(i / 6 / n + corner[i % 6][1]) / n;
            p[0] += cube;
            triangles[count] = (pbw_index)count;
        }
    }
    return count / 3;
}

/* q = stiffness d, by tetrahedra, but for fixed points; b, if not NULL: plus the load 2 (x - 1) sin y cos z.  Returns
   the product of d and q. */
static double apply(const heat *h, const double *d, double *q, double *b)
{
    double product = 0;
    memset(q, 0, h->t->point_count * sizeof *q);
    for (size_t i = 0; i < h->t->tet_count; i++) {
        const pbw_index *v = h->t->corners + 4 * i;
        double g[4][3], flow[3] = { 0, 0, 0 }, volume6 = 0;
        for (int k = 0; k < 4; k++) {                /* g: across from corner k, outward, twice the area long */
            const double *a = h->t->points + 3 * v[PBW_FACET_CORNER(k, 0)], *p = h->t->points + 3 * v[k];
            const double *s = h->t->points + 3 * v[PBW_FACET_CORNER(k, 1)];
            const double *t = h->t->points + 3 * v[PBW_FACET_CORNER(k, 2)];
            for (int x = 0, y = 1, z = 2; x < 3; x++, y = (y + 1) % 3, z = (z + 1) % 3) {
                g[k][x] = (s[y] - a[y]) * (t[z] - a[z]) - (s[z] - a[z]) * (t[y] - a[y]);
                flow[x] += d[v[k]] * g[k][x];
                volume6 += k == 0 ? g[k][x] * (a[x] - p[x]) : 0;
            }
            if (b != NULL) {                         /* of the corner's quarter of the tetrahedron */
                b[v[k]] += volume6 / 24 * 2 * (p[0] - 1) * sin(p[1]) * cos(p[2]);
            }
        }
        for (int k = 0; k < 4; k++) {
            q[v[k]] += conductivity[h->t->regions[i]] / (6 * volume6)
                     * (flow[0] * g[k][0] + flow[1] * g[k][1] + flow[2] * g[k][2]);
        }
    }
    for (size_t i = 0; i < h->t->point_count; i++) {
        q[i] = h->fixed[i] ? 0 : q[i];
        product += d[i] * q[i];
    }
    return product;
}

/* Conjugate gradients.  Returns the largest error at a point. */
static double solve(const heat *h, int curved)
{
    const size_t n = h->t->point_count;
    double error = 0, old = 0;
    for (size_t i = 0; i < n; i++) {
        h->u[i] = h->fixed[i] ? exact(h->t->points + 3 * i, curved) : 0;
    }
    apply(h, h->u, h->q, curved ? h->b : NULL);
    for (size_t i = 0; i < n; i++) {
        h->d[i] = h->r[i] = h->fixed[i] ? 0 : h->b[i] - h->q[i];
        old += h->r[i] * h->r[i];
    }
    for (int k = 0; k < 2000 && old > 1e-28; k++) {
        const double before = old, along = old / apply(h, h->d, h->q, NULL);
        old = 0;
        for (size_t i = 0; i < n; i++) {
            h->u[i] += along * h->d[i];
            h->r[i] -= along * h->q[i];
            old += h->r[i] * h->r[i];
        }
        for (size_t i = 0; i < n; i++) {
            h->d[i] = h->r[i] + old / before * h->d[i];
        }
    }
    for (size_t i = 0; i < n; i++) {
        error = fmax(error, fabs(h->u[i] - exact(h->t->points + 3 * i, curved)));
    }
    return error;
}

/* Fills the surface of n by n squares a side.  Returns the error of the second solution; 1: the first is wrong. */
static double solve_both(int n)
{
    const size_t count = make_surface(n);
    const pbw_fill_input input = { points, 3 * count, triangles, count, NULL, NULL, 0, NULL, NULL, 0 };
    pbw_fill_options how = { 0 };
    pbw_filled f = { 0 };
    how.size = 1.0 / n;
    how.improve.target = 15;
    if (pbw_fill(&input, &how, NULL, &f, NULL) != PBW_OK) {
        return 1;
    }
    const size_t k = f.tets.point_count;
    double *m = (double *)calloc(6 * k + 1, sizeof *m);
    const heat h = { &f.tets, m, m + k, m + 2 * k, m + 3 * k, m + 4 * k, (unsigned char *)(m + 5 * k) };
    for (size_t i = 0; i < 3 * f.facet_count; i++) {
        h.fixed[f.facets[i]] |= (unsigned char)(f.sides[2 * (i / 3) + 1] == PBW_NONE);      /* the outside is there */
    }
    const int good = solve(&h, 0) < 1e-9;
    const double error = good ? solve(&h, 1) : 1;
    printf("edges of 1/%d: %zu facets; linear: %s\n", n, f.facet_count, good ? "exact" : "wrong");
    free(m);
    pbw_fill_free(&f);
    return error;
}

int main(void)
{
    const double coarse = solve_both(MOST / 3), fine = solve_both(MOST);
    const int good = fine < 0.234 * coarse && fine < 1.5e-3;         /* 0.4 for each half */
    printf("a third of the size, at most 0.234 of the error: %s\n", good ? "yes" : "no");
    return !good;
}
