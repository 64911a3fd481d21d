/* adapt.c: a mesh that follows the error: the Laplace equation on an L-shaped domain, whose corner is a singularity.
   cc -O2 -I. -Iexamples/lib examples/adapt.c -o adapt -lpthread -lm
   Prints expected/adapt.txt; the exit status is 1 unless the squared error in the H1 seminorm falls as the number of
   unknowns to the power -1, as it does for smooth solutions; equal triangles would reach -2/3 only.
   u = r^(2/3) sin(2/3 phi) solves it.  Linear elements, conjugate gradients; what drives the mesh is the jump of the
   normal derivative across edges.  Each mesh begins with the solution of the last one, carried over. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#define PBW_ADAPT2_IMPLEMENTATION
#include "pbw_adapt2.h"

enum { ROUNDS = 9 };

static double exact(double x, double y, double gradient[2])
{
    const double r = sqrt(x * x + y * y) + 1e-300, phi = atan2(y, x) + (y < 0 ? 2 * acos(-1.0) : 0);
    gradient[0] = -2 / 3.0 * pow(r, -1 / 3.0) * sin(phi / 3);
    gradient[1] = 2 / 3.0 * pow(r, -1 / 3.0) * cos(phi / 3);
    return pow(r, 2 / 3.0) * sin(2 / 3.0 * phi);
}

/* The gradients of the three linear functions of triangle i; returns its area. */
static double gradients(const pbw_plane *p, size_t i, double g[3][2])
{
    const pbw_index *v = p->triangles + 3 * i;
    const double *a = p->points + 2 * v[0], *b = p->points + 2 * v[1], *c = p->points + 2 * v[2];
    const double twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    for (int k = 0; k < 3; k++) {
        const double *s = p->points + 2 * v[(k + 1) % 3], *t = p->points + 2 * v[(k + 2) % 3];
        g[k][0] = (s[1] - t[1]) / twice;
        g[k][1] = (t[0] - s[0]) / twice;
    }
    return twice / 2;
}

/* out = stiffness in, 0 at fixed points. */
static void apply(const pbw_plane *p, const unsigned char *fixed, const double *in, double *out)
{
    memset(out, 0, p->point_count * sizeof *out);
    for (size_t i = 0; i < p->triangle_count; i++) {
        const pbw_index *v = p->triangles + 3 * i;
        double g[3][2], u[2] = { 0, 0 };
        const double area = gradients(p, i, g);
        for (int k = 0; k < 6; k++) {
            u[k % 2] += in[v[k / 2]] * g[k / 2][k % 2];
        }
        for (int k = 0; k < 3; k++) {
            out[v[k]] += fixed[v[k]] ? 0 : area * (u[0] * g[k][0] + u[1] * g[k][1]);
        }
    }
}

/* By halves, so that roundings do not add up. */
static double dot(size_t n, const double *a, const double *b)
{
    return n == 0 ? 0 : n == 1 ? a[0] * b[0] : dot(n / 2, a, b) + dot(n - n / 2, a + n / 2, b + n / 2);
}

static void solve(const pbw_plane *p, const unsigned char *fixed, double *u, double *work)
{
    const size_t n = p->point_count;
    double *r = work, *d = work + n, *q = work + 2 * n, unused[2], old, next, along;
    for (size_t i = 0; i < n; i++) {
        u[i] = fixed[i] ? exact(p->points[2 * i], p->points[2 * i + 1], unused) : u[i];
    }
    apply(p, fixed, u, q);
    for (size_t i = 0; i < n; i++) {
        d[i] = r[i] = -q[i];
    }
    for (old = dot(n, r, r); old > 1e-18; old = next) {
        apply(p, fixed, d, q);
        along = old / dot(n, d, q);
        for (size_t i = 0; i < n; i++) {
            u[i] += along * d[i];
            r[i] -= along * q[i];
        }
        next = dot(n, r, r);
        for (size_t i = 0; i < n; i++) {
            d[i] = r[i] + next / old * d[i];
        }
    }
}

/* Estimates of the error, one a triangle; returns the true one, squared, by three places in each triangle. */
static double judge(const pbw_plane *p, const double *u, double *slope, double *estimate)
{
    double sum = 0;
    for (size_t i = 0; i < p->triangle_count; i++) {
        const pbw_index *v = p->triangles + 3 * i;
        double g[3][2], wrong[2], area = gradients(p, i, g);
        for (unsigned k = 0; k < 2; k++) {
            slope[2 * i + k] = u[v[0]] * g[0][k] + u[v[1]] * g[1][k] + u[v[2]] * g[2][k];
        }
        for (int k = 0; k < 3; k++) {
            const double *a = p->points + 2 * v[k], *b = p->points + 2 * v[(k + 1) % 3];
            const double *c = p->points + 2 * v[(k + 2) % 3];
            exact((4 * a[0] + b[0] + c[0]) / 6, (4 * a[1] + b[1] + c[1]) / 6, wrong);
            sum += area / 3 * (pow(wrong[0] - slope[2 * i], 2) + pow(wrong[1] - slope[2 * i + 1], 2));
        }
    }
    for (size_t i = 0; i < 3 * p->triangle_count; i++) {
        if (p->neighbors[i] != PBW_NONE) {
            const double *s = p->points + 2 * p->triangles[i - i % 3 + (i + 1) % 3], *one = slope + 2 * (i / 3);
            const double *t = p->points + 2 * p->triangles[i - i % 3 + (i + 2) % 3];
            const double *other = slope + 2 * p->neighbors[i];
            estimate[i / 3] += fabs((one[0] - other[0]) * (t[1] - s[1]) - (one[1] - other[1]) * (t[0] - s[0]));
        }
    }
    return sum;
}

int main(void)
{
    const double points[] = { 0, 0, 1, 0, 1, 1, -1, 1, -1, -1, 0, -1 };
    const size_t first[] = { 0, 6 };
    const pbw_plane_options options = { .flags = PBW_PLANE_REFINE, .size = 0.5 };
    pbw_plane p = { 0 }, next = { 0 };
    double *work = NULL, *old, error[ROUNDS] = { 0 }, unknowns[ROUNDS], power;
    pbw_status status = pbw_plane_rings(points, first, 1, &options, &p);
    for (int round = 0; round < ROUNDS && status == PBW_OK; round++) {
        const size_t n = p.point_count, triangles = p.triangle_count;
        old = work;                                  /* u, three for solve, sizes, fixed; slopes, estimate */
        work = (double *)calloc(6 * n + 3 * triangles, sizeof *work);
        unsigned char *fixed = (unsigned char *)(work + 5 * n);
        if (work == NULL || (round > 0 && pbw_plane_transfer(&next, &p, old, 1, work, NULL) != PBW_OK)) {
            return 1;
        }
        for (size_t i = 0; i < 2 * p.edge_count; i++) {
            fixed[p.edges[i]] = 1;
        }
        solve(&p, fixed, work, work + n);
        error[round] = judge(&p, work, work + 6 * n, work + 6 * n + 2 * triangles);
        unknowns[round] = (double)(n - p.edge_count);
        fprintf(stderr, "%zu unknowns, squared error %.1e\n", n - p.edge_count, error[round]);
        pbw_plane_sizes(&p, work + 6 * n + 2 * triangles, 2 * triangles, work + 4 * n);
        pbw_plane_free(&next);
        next = p;
        status = pbw_plane_adapt(&next, work + 4 * n, NULL, &options, &p, NULL);
        free(old);
    }
    power = log(error[ROUNDS - 1] / error[5]) / log(unknowns[ROUNDS - 1] / unknowns[5]);
    printf("power %.1f\n", power);
    free(work);
    pbw_plane_free(&next);
    pbw_plane_free(&p);
    return !(power > -1.1 && power < -0.9);
}
