/* alpha.c: the surface of a scanned ring from nothing but noisy points: the outer boundary of the alpha shape.
   cc -O2 -I. examples/alpha.c -o alpha -lpthread -lm
   alpha ring.obj also writes the surface.  Prints expected/alpha.txt.
   A ball of radius alpha with no point in it comes from outside and carves every tetrahedron that it can reach
   (Edelsbrunner and Muecke 1994, "Three-dimensional alpha shapes").  The boundary of the rest is closed, and its
   Euler number tells how many handles it has. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { COUNT = 20000 };

/* A ring of radii 1 and 0.4: random points of a box, pulled to the surface, with noise of +-0.005. */
static void scan(double *points)
{
    unsigned long long state = 1;
    for (int i = 0; i < COUNT;) {
        double r[4], far, near, x, y;
        for (int k = 0; k < 4; k++) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            r[k] = (double)(state >> 11) / 4503599627370496.0 - 1;
        }
        x = 1.5 * r[0], y = 1.5 * r[1];
        far = sqrt(x * x + y * y);
        near = sqrt((far - 1) * (far - 1) + r[2] * r[2] / 4);        /* distance from the ring's middle line */
        if (far > 0.5 && near > 0.1 && near < 0.5) {
            double scale = (0.4 + 0.005 * r[3]) / near, out = 1 + (far - 1) * scale;
            points[3 * i] = x / far * out;
            points[3 * i + 1] = y / far * out;
            points[3 * i++ + 2] = r[2] / 2 * scale;
        }
    }
}

static double dot(const double *u, const double *v)
{
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

static void cross(const double *u, const double *v, double *result)
{
    for (int k = 0; k < 3; k++) {
        result[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    }
}

/* Squared radius of the sphere through 0, u, v, w, or the smallest one through 0, u, v if w is NULL; its centre. */
static double sphere(const double *u, const double *v, const double *w, double *center)
{
    double uv[3], vw[3], wu[3];
    cross(u, v, uv);
    cross(v, w != NULL ? w : uv, vw);
    cross(w != NULL ? w : uv, u, wu);
    for (int k = 0; k < 3; k++) {
        double third = w != NULL ? dot(w, w) * uv[k] : 0;
        center[k] = (dot(u, u) * vw[k] + dot(v, v) * wu[k] + third) / (2 * dot(u, vw));
    }
    return dot(center, center);
}

/* Whether a ball of squared radius alpha2 gets through facet f of tetrahedron t.  Its centre moves along the dual
   edge of the Voronoi diagram, from one circumcentre to the other (or to infinity), and the least clearance there is
   the facet's own radius, or, if an opposite corner is within its sphere, the lesser of those of the tetrahedra. */
static int passes(const pbw_mesh *mesh, size_t t, int f, double alpha2)
{
    const double *a = mesh->points + 3 * mesh->simplices[4 * t + PBW_FACET_CORNER(f, 0)];
    pbw_index n = mesh->neighbors[4 * t + (size_t)f];
    double edge[3][3], center[3], other[3], clearance = 0, least = HUGE_VAL;
    int within = 0;
    for (int side = 0; side < 2 && (side == 0 || n != PBW_NONE); side++) {
        size_t apex = 4 * t + (size_t)f;
        if (side == 1) {
            for (apex = 4 * (size_t)n; mesh->neighbors[apex] != t; apex++) {}
        }
        for (int k = 0; k < 9; k++) {
            size_t from = k < 6 ? 4 * t + PBW_FACET_CORNER(f, k / 3 + 1) : apex;
            edge[k / 3][k % 3] = mesh->points[3 * mesh->simplices[from] + (size_t)(k % 3)] - a[k % 3];
        }
        least = fmin(least, sphere(edge[0], edge[1], edge[2], other));
        clearance = sphere(edge[0], edge[1], NULL, center);
        within |= dot(edge[2], edge[2]) < 2 * dot(edge[2], center);          /* |apex - center| < |center| */
    }
    return (within ? least : clearance) > alpha2;
}

int main(int argc, char **argv)
{
    static double points[3 * COUNT];
    static char on_surface[COUNT];
    const double alpha = 0.12;
    pbw_mesh mesh = { 0 };
    pbw_status status;
    pbw_index *stack;
    char *carved;
    size_t count, top = 0, facets = 0, vertices = 0;
    FILE *file = argc > 1 ? fopen(argv[1], "w") : NULL;
    scan(points);
    status = pbw_triangulate(3, points, NULL, COUNT, NULL, &mesh);
    count = mesh.simplex_count;
    stack = (pbw_index *)malloc((count + 1) * sizeof *stack);
    carved = (char *)calloc(count + 1, 1);
    if (status != PBW_OK || stack == NULL || carved == NULL) {
        printf("%s\n", pbw_status_string(status == PBW_OK ? PBW_ERROR_MEMORY : status));
        return 1;
    }
    /* Facet f of tetrahedron t is number 4t + f.  First the hull facets, then those of each carved tetrahedron. */
    for (size_t t = 0, next = 0; t < count || next < top;) {
        size_t from = t < count ? t++ : stack[next++];
        for (int f = 0; f < 4; f++) {
            pbw_index n = mesh.neighbors[4 * from + (size_t)f];
            pbw_index into = carved[from] ? n : n == PBW_NONE ? (pbw_index)from : PBW_NONE;
            if (into != PBW_NONE && !carved[into] && passes(&mesh, from, f, alpha * alpha)) {
                carved[into] = 1;
                stack[top++] = into;
            }
        }
    }
    for (int i = 0; file != NULL && i < COUNT; i++) {
        fprintf(file, "v %.17g %.17g %.17g\n", points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    }
    for (size_t i = 0; i < 4 * count; i++) {
        if (!carved[i / 4] && (mesh.neighbors[i] == PBW_NONE || carved[mesh.neighbors[i]])) {
            pbw_index id[3];
            for (int k = 0; k < 3; k++) {
                id[k] = mesh.simplices[i - i % 4 + PBW_FACET_CORNER(i % 4, k)];
                vertices += !on_surface[id[k]];
                on_surface[id[k]] = 1;
            }
            facets++;
            if (file != NULL) {
                fprintf(file, "f %u %u %u\n", id[0] + 1, id[1] + 1, id[2] + 1);
            }
        }
    }
    printf("%zu of %zu tetrahedra carved\n", top, count);
    printf("surface: %zu vertices, %zu facets; vertices - edges + facets = %ld (0: one handle)\n", vertices, facets,
           (long)vertices - (long)(facets / 2));
    if (argc > 1 && (file == NULL || ferror(file) | fclose(file))) {
        perror(argv[1]);
        return 1;
    }
    free(stack);
    free(carved);
    pbw_free(&mesh);
    return 0;
}
