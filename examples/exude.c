/* exude.c: flat tetrahedra pushed out by weights: a regular triangulation without moving a point.
   cc -O2 -I. -Iexamples/lib examples/exude.c -o exude -lpthread -lm
   Prints expected/exude.txt; the exit status is 1 if an angle below 5 degrees or a hidden point remains.
   Even of well-spaced points the Delaunay triangulation has slivers: flat tetrahedra without short edges.  Weights
   below a quarter of the squared distance to the nearest other point hide none, and change which tetrahedra there are
   (Cheng, Dey, Edelsbrunner, Facello, Teng 2000, "Sliver exudation").  Rounds try weights far from each other. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#include <stdio.h>
#include <string.h>

enum { N = 12, COUNT = N * N * N, ROUNDS = 200 };

static double points[3 * COUNT], weights[COUNT], most[COUNT];
static unsigned char inner[COUNT];
static uint64_t state = 1;

static double uniform(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) / 9007199254740992.0;
}

static double angle_of(const pbw_mesh *mesh, size_t t)
{
    const pbw_index *c = mesh->simplices + 4 * t;
    return pbw_tet_measure(PBW_MEASURE_LEAST_DIHEDRAL, points + 3 * c[0], points + 3 * c[1], points + 3 * c[2],
                           points + 3 * c[3]);
}

/* Tetrahedra with a point of the outer layers do not count: their angles are the hull's. */
static int is_inner(const pbw_mesh *mesh, size_t t)
{
    const pbw_index *c = mesh->simplices + 4 * t;
    return inner[c[0]] && inner[c[1]] && inner[c[2]] && inner[c[3]];
}

/* How many degrees lack to 15, of all tetrahedra of each point. */
static void find_lacks(const pbw_mesh *mesh, double *lack)
{
    memset(lack, 0, COUNT * sizeof *lack);
    for (size_t t = 0; t < mesh->simplex_count; t++) {
        const double a = is_inner(mesh, t) ? angle_of(mesh, t) : 15;
        for (size_t k = 0; k < 4; k++) {
            lack[mesh->simplices[4 * t + k]] += a < 15 ? 15 - a : 0;
        }
    }
}

/* The sum, or the most, over the neighbours of each point. */
static void spread(const pbw_mesh *mesh, int sums, const double *from, double *to)
{
    memset(to, 0, COUNT * sizeof *to);
    for (size_t i = 0; i < 16 * mesh->simplex_count; i++) {
        const pbw_index *c = mesh->simplices + i / 16 * 4, p = c[i % 4], q = c[i / 4 % 4];
        to[p] = sums ? to[p] + from[q] : from[q] > to[p] ? from[q] : to[p];
    }
}

static size_t report(const char *what, const pbw_mesh *mesh)
{
    size_t below[3] = { 0, 0, 0 }, all = 0;
    for (size_t t = 0; t < mesh->simplex_count; t++) {
        const double a = angle_of(mesh, t);
        all += (size_t)is_inner(mesh, t);
        for (int k = 0; k < 3 && is_inner(mesh, t); k++) {
            below[k] += a < 5 * (k + 1);
        }
    }
    printf("%s: %zu inside, below 5, 10, 15 degrees: %zu, %zu, %zu\n", what, all, below[0], below[1], below[2]);
    return below[0];
}

/* A lattice, each point moved by up to a quarter of a cell, and the most that it may weigh. */
static void make_points(void)
{
    for (size_t i = 0; i < COUNT; i++) {
        const size_t at[3] = { i % N, i / N % N, i / N / N };
        inner[i] = 1;
        for (int k = 0; k < 3; k++) {
            points[3 * i + (size_t)k] = ((double)at[k] + (uniform() - 0.5) / 2) / N;
            inner[i] &= at[k] > 1 && at[k] < N - 2;
        }
    }
    for (size_t i = 0; i < COUNT; i++) {
        most[i] = 1;
        for (size_t j = 0; j < COUNT; j++) {
            const double *p = points + 3 * i, *q = points + 3 * j, x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
            const double w = 0.24 * (x * x + y * y + z * z);
            most[i] = j != i && w < most[i] ? w : most[i];
        }
    }
}

/* Gives new weights to points of slivers that are three edges from each other, and takes back those that do not
   help: what lacks around a point, in the old neighbourhood, falls if a weight helps. */
static pbw_status try_weights(pbw_mesh *mesh)
{
    static double rank[COUNT], top[2][COUNT], lack[COUNT], around[2][COUNT], old[COUNT];
    pbw_mesh next = { 0 };
    pbw_status status;
    find_lacks(mesh, lack);
    spread(mesh, 1, lack, around[0]);
    for (size_t i = 0; i < COUNT; i++) {
        rank[i] = inner[i] && lack[i] > 0 ? uniform() : 0;
    }
    spread(mesh, 0, rank, top[0]);
    spread(mesh, 0, top[0], top[1]);
    spread(mesh, 0, top[1], top[0]);
    memcpy(old, weights, sizeof old);
    for (size_t i = 0; i < COUNT; i++) {
        weights[i] = rank[i] > 0 && rank[i] >= top[0][i] ? most[i] * uniform() : weights[i];
    }
    status = pbw_triangulate(3, points, weights, COUNT, NULL, &next);
    if (status == PBW_OK) {
        find_lacks(&next, lack);
        spread(mesh, 1, lack, around[1]);
        for (size_t i = 0; i < COUNT; i++) {
            weights[i] = around[1][i] < around[0][i] ? weights[i] : old[i];
        }
        pbw_free(&next);
        pbw_free(mesh);
        status = pbw_triangulate(3, points, weights, COUNT, NULL, mesh);
    }
    return status;
}

int main(void)
{
    pbw_mesh mesh = { 0 };
    pbw_status status;
    size_t left;
    make_points();
    status = pbw_triangulate(3, points, NULL, COUNT, NULL, &mesh);
    (void)report("Delaunay", &mesh);
    for (int round = 0; round < ROUNDS && status == PBW_OK; round++) {
        status = try_weights(&mesh);
    }
    if (status != PBW_OK) {
        puts(pbw_status_string(status));
        return 1;
    }
    left = report("regular", &mesh) + mesh.hidden_count;
    pbw_free(&mesh);
    return left > 0;
}
