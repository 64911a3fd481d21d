/* alpha_molecule.c: what molecules enclose: the alpha shape of atoms of different radii, its volume, its cavities.
   cc -O2 -I. -Iexamples/lib examples/alpha_molecule.c -o alpha_molecule -lpthread -lm
   alpha_molecule shape.svg also draws the tetrahedra of the last shape, cut.  Prints expected/alpha_molecule.txt.
   Atoms: 13 fullerenes C60 as in their crystal, the middle one with helium; radii of van der Waals and a probe that
   rolls over them; weights are their squares.  A simplex of the regular triangulation is in the shape if its balls
   have a point in common that is in no other ball, or as a face of such a one (Edelsbrunner 1995, "The union of
   balls and its dual shape").  A cavity is what is left within, and cannot be left but through facets. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_IO_IMPLEMENTATION
#include "pbw_io.h"
#define PBW_PICTURE_IMPLEMENTATION
#include "pbw_picture.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { ATOMS = 60 * 13 + 1, MOST = 10 * ATOMS };
static double points[3 * ATOMS], radii[ATOMS], weights[ATOMS];
static unsigned char kind[MOST], kept[MOST];         /* tetrahedra: 1 in the shape, 2 outside, 3 in a cavity; 1 */

/* C60 is a truncated icosahedron with edges of 1.42 A; cubes of 14.17 A have it at their corners and faces.  Their
   atoms are moved by their heat, up to 0.05 A along each axis. */
static void make_atoms(void)
{
    const double g = (1 + sqrt(5)) / 2, corner[3][3] = { { 0, 1, 3 * g }, { 1, 2 + g, 2 * g }, { g, 2, 2 * g + 1 } };
    unsigned long long state = 1;
    int count = 0;
    for (int i = 0; i < 27 * 72; i++) {              /* a place; a corner, its turn among the axes, three signs */
        const int place[3] = { i / 72 % 3 - 1, i / 72 / 3 % 3 - 1, i / 72 / 9 - 1 }, c = i % 72 / 24;
        if (abs(place[0]) + abs(place[1]) + abs(place[2]) == (i / 72 == 13 ? 0 : 2) && (c != 0 || (i & 1) == 0)) {
            for (int k = 0; k < 3; k++) {            /* 0 has one sign */
                double *x = points + 3 * count + (k + i / 8) % 3;
                state = state * 6364136223846793005u + 1442695040888963407u;
                *x = 0.71 * corner[c][k] * ((i >> k & 1) != 0 ? -1 : 1) + 7.085 * place[(k + i / 8) % 3]
                     + 0.1 * ((double)(state >> 11) / 9007199254740992.0 - 0.5);
            }
            radii[count++] = 1.7;
        }
    }
    radii[count] = 1.4;                              /* in the middle */
}

static double dot(const double *u, const double *v)
{
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

static void cross(const double *u, const double *v, double *out)
{
    for (int k = 0; k < 3; k++) {
        out[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    }
}

/* A tetrahedron as its facet across from corner f sees it: the power of the smallest sphere that is orthogonal to
   the balls of the facet, and of that of all four; whether the fourth ball reaches into the first sphere. */
typedef struct shape { double area, volume, facet_power, power; int reached; } shape;

static shape measure(const pbw_mesh *mesh, size_t t, size_t f)
{
    const pbw_index *id = mesh->simplices + 4 * t, first = id[(f + 1) % 4];
    double e[3][3], n[3], uv[3], vw[3], height[3], c[3], to[3], det, power, rise;
    for (size_t i = 0; i < 3; i++) {
        const pbw_index other = id[(f + 2 + i) % 4];
        for (size_t k = 0; k < 3; k++) {
            e[i][k] = points[3 * other + k] - points[3 * first + k];
        }
        height[i] = (dot(e[i], e[i]) + weights[first] - weights[other]) / 2;
    }
    cross(e[0], e[1], n);
    cross(e[1], n, vw);
    cross(n, e[0], uv);
    for (int k = 0; k < 3; k++) {                    /* the point of equal powers in the facet's plane */
        c[k] = (height[0] * vw[k] + height[1] * uv[k]) / dot(n, n);
        to[k] = e[2][k] - c[k];
    }
    det = dot(n, e[2]);
    power = dot(c, c) - weights[first];
    rise = (height[2] - dot(c, e[2])) / det;
    return (shape){ sqrt(dot(n, n)) / 2, fabs(det) / 6, power, power + rise * rise * dot(n, n),
                    dot(to, to) - weights[id[f]] < power };
}

static int has_facet(const pbw_mesh *mesh, size_t t, size_t f)
{
    const pbw_index n = mesh->neighbors[4 * t + f];
    const shape s = measure(mesh, t, f);
    size_t g = 0;
    for (; n != PBW_NONE && mesh->neighbors[4 * n + g] != t; g++) {}
    return kind[t] == 1 || (n != PBW_NONE && kind[n] == 1)
           || (s.facet_power <= 0 && !s.reached && (n == PBW_NONE || !measure(mesh, n, g).reached));
}

static void print_shape(const pbw_mesh *mesh, double probe)
{
    static pbw_index stack[MOST];
    double volume[4] = { 0 }, area = 0;
    size_t count = mesh->simplex_count, cavities = 0, top = 0;
    for (size_t t = 0; t < count; t++) {
        kind[t] = measure(mesh, t, 0).power <= 0;
    }
    for (size_t i = 0; i < 8 * count; i++) {         /* fills from the hull; then what is left */
        const size_t from = i / 4 % count, pass = i / 4 / count;
        if (kind[from] == 0 && (pass == 1 || (mesh->neighbors[i] == PBW_NONE && !has_facet(mesh, from, i % 4)))) {
            cavities += pass;
            kind[from] = (unsigned char)(2 + pass);
            for (stack[top++] = (pbw_index)from; top > 0; ) {
                const size_t t = stack[--top];
                for (size_t f = 0; f < 4; f++) {
                    const pbw_index n = mesh->neighbors[4 * t + f];
                    if (n != PBW_NONE && kind[n] == 0 && !has_facet(mesh, t, f)) {
                        kind[n] = kind[t];
                        stack[top++] = n;
                    }
                }
            }
        }
    }
    for (size_t i = 0; i < 4 * count; i++) {         /* the sides of facets that face no tetrahedron of the shape */
        const int sides = (kind[i / 4] != 1) + (mesh->neighbors[i] == PBW_NONE);
        kept[i / 4] = kind[i / 4] == 1;
        volume[kind[i / 4]] += measure(mesh, i / 4, i % 4).volume / 4;
        area += sides > 0 && has_facet(mesh, i / 4, i % 4) ? sides * measure(mesh, i / 4, i % 4).area : 0;
    }
    printf("%5.1f %8.1f %8.1f %9zu %8.1f\n", probe, volume[1], area, cavities, volume[3]);
}

int main(int argc, char **argv)
{
    static const double probes[4] = { 0, 0.7, 2.1, 1.7 };
    const pbwpic_options picture = { kept, { 0 }, { 0 }, { 0, -1, 0, 0 }, NULL };
    make_atoms();
    printf("%d atoms\nprobe   volume     area  cavities   volume\n", ATOMS);
    for (int i = 0; i < 4; i++) {
        pbw_mesh mesh = { 0 };
        for (int k = 0; k < ATOMS; k++) {
            weights[k] = (radii[k] + probes[i]) * (radii[k] + probes[i]);
        }
        if (pbw_triangulate(3, points, weights, ATOMS, NULL, &mesh) != PBW_OK || mesh.simplex_count > MOST) {
            return 1;
        }
        print_shape(&mesh, probes[i]);
        if (argc > 1 && i == 3 && pbwpic_write(argv[1], &mesh, &picture, NULL) != PBWIO_OK) {
            return 1;
        }
        pbw_free(&mesh);
    }
    return 0;
}
