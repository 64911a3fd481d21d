/* zoo.h: about 400 named inputs of the kinds that have broken triangulation codes: tiny and flat sets, symmetric
   solids, lattices, cospherical sets, quadratic outputs, ulp-sized perturbations, scales and offsets, sets like those
   of applications, weights, extreme exponents, and numbers that are not finite.  C99 and C++.

       zoo animals;
       zoo_fill(&animals);
       for (i = 0; i < animals.count; i++) { ... animals.items[i] ... }
       zoo_free(&animals); */
#ifndef ZOO_H
#define ZOO_H

#include "inputs.h"
#include <float.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* As in inputs.h: -march=native must not change the points. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif

typedef struct zoo_input {
    char name[80];                      /* unique; begins with 2D or 3D */
    int dim, finite;                    /* finite 0: some number is NaN or infinite */
    size_t count, capacity;
    size_t simplices;                   /* their number where theory tells it, else 0 */
    double *points, *weights;           /* weights NULL: Delaunay */
} zoo_input;

typedef struct zoo {
    zoo_input *items;
    size_t count, capacity;
    uint64_t state;
} zoo;

/* --- making: each function works on the last input of the zoo --- */

static inline zoo_input *zoo_last(zoo *z)
{
    return z->items + z->count - 1;
}

static inline void *zoo_grow(void *block, size_t size)
{
    void *grown = realloc(block, size);
    if (grown == NULL) {
        fprintf(stderr, "out of memory\n");
        exit(2);
    }
    return grown;
}

static inline void zoo_new(zoo *z, int dim, const char *format, ...)
{
    zoo_input *in;
    va_list arguments;
    int length;
    if (z->count == z->capacity) {
        z->capacity = 2 * z->capacity + 16;
        z->items = (zoo_input *)zoo_grow(z->items, z->capacity * sizeof *z->items);
    }
    z->count++;
    in = zoo_last(z);
    memset(in, 0, sizeof *in);
    in->dim = dim;
    in->finite = 1;
    length = snprintf(in->name, sizeof in->name, "%dD ", dim);
    va_start(arguments, format);
    vsnprintf(in->name + length, sizeof in->name - (size_t)length, format, arguments);
    va_end(arguments);
}

static inline void zoo_add(zoo *z, double x, double y, double zz)
{
    zoo_input *in = zoo_last(z);
    double *p;
    if (in->count == in->capacity) {
        in->capacity = 2 * in->capacity + 16;
        in->points = (double *)zoo_grow(in->points, in->capacity * 3 * sizeof *in->points);
    }
    p = in->points + in->count * (size_t)in->dim;
    p[0] = x;
    p[1] = y;
    if (in->dim == 3) {
        p[2] = zz;
    }
    in->count++;
}

/* A new input that begins as the last one, its name with something added. */
static inline void zoo_copy(zoo *z, const char *suffix)
{
    zoo_input in = *zoo_last(z);
    size_t i;
    zoo_new(z, in.dim, "%s, %s", in.name + 3, suffix);
    for (i = 0; i < in.count; i++) {
        const double *p = in.points + i * (size_t)in.dim;
        zoo_add(z, p[0], p[1], in.dim == 3 ? p[2] : 0);
    }
    zoo_last(z)->simplices = in.simplices;
}

static inline void zoo_known(zoo *z, size_t simplices)
{
    zoo_last(z)->simplices = simplices;
}

static inline void zoo_shuffle(zoo *z)
{
    zoo_input *in = zoo_last(z);
    input_shuffle(in->dim, in->count, &z->state, in->points);
}

static inline void zoo_scale(zoo *z, double scale, double offset)
{
    zoo_input *in = zoo_last(z);
    size_t i;
    for (i = 0; i < in->count * (size_t)in->dim; i++) {
        in->points[i] = in->points[i] * scale + offset;
    }
}

/* Turns the first two axes, then in 3D the last two. */
static inline void zoo_tilt(zoo *z, double turns)
{
    zoo_input *in = zoo_last(z);
    double c, s;
    size_t i;
    int axis;
    input_turn(turns, &c, &s);
    for (axis = 0; axis < in->dim - 1; axis++) {
        for (i = 0; i < in->count; i++) {
            double *p = in->points + i * (size_t)in->dim + axis;
            volatile double cx = c * p[0], sy = s * p[1], sx = s * p[0], cy = c * p[1];
            p[0] = cx - sy;                           /* volatile: gcc 12 fuses such pairs whatever it is told */
            p[1] = sx + cy;
        }
    }
    in->simplices = 0;
}

/* Moves each coordinate by -1, 0 or 1 ulp. */
static inline void zoo_nudge(zoo *z)
{
    zoo_input *in = zoo_last(z);
    size_t i;
    for (i = 0; i < in->count * (size_t)in->dim; i++) {
        uint64_t bits;
        memcpy(&bits, in->points + i, sizeof bits);
        bits += bits << 1 == 0 ? 0 : (uint64_t)input_below(&z->state, 3) - 1;
        memcpy(in->points + i, &bits, sizeof bits);
    }
    in->simplices = 0;
}

static inline void zoo_to_float(zoo *z)
{
    zoo_input *in = zoo_last(z);
    size_t i;
    for (i = 0; i < in->count * (size_t)in->dim; i++) {
        in->points[i] = (double)(float)in->points[i];
    }
    in->simplices = 0;
}

static inline void zoo_repeat(zoo *z, int times)
{
    zoo_input *in = zoo_last(z);
    size_t i, n = in->count;
    for (; times > 1; times--) {
        for (i = 0; i < n; i++) {
            double p[3] = { 0, 0, 0 };
            memcpy(p, zoo_last(z)->points + i * (size_t)in->dim, (size_t)in->dim * sizeof *p);
            zoo_add(z, p[0], p[1], p[2]);
        }
    }
}

static inline void zoo_random(zoo *z, size_t n, double scale)                /* uniform in [0, scale) */
{
    for (; n > 0; n--) {
        double x = scale * input_uniform(&z->state), y = scale * input_uniform(&z->state);
        zoo_add(z, x, y, scale * input_uniform(&z->state));
    }
}

static inline void zoo_kind(zoo *z, int dim, int kind, size_t n)
{
    zoo_input *in;
    zoo_new(z, dim, "%s %d", input_name(kind), (int)n);
    in = zoo_last(z);
    in->count = in->capacity = n;
    in->points = (double *)zoo_grow(NULL, n * 3 * sizeof *in->points);
    input_fill(kind, dim, n, 1, in->points);
}

static inline void zoo_grid(zoo *z, int nx, int ny, int nz, double step)
{
    int i, j, k;
    for (i = 0; i < nx; i++) {
        for (j = 0; j < ny; j++) {
            for (k = 0; k < nz; k++) {
                zoo_add(z, i * step, j * step, k * step);
            }
        }
    }
}

static inline void zoo_ring(zoo *z, int n, double radius, double height)     /* rounded: nearly cocircular */
{
    double c, s;
    int i;
    for (i = 0; i < n; i++) {
        input_turn((double)i / n, &c, &s);
        zoo_add(z, radius * c, radius * s, height);
    }
}

static inline void zoo_integer_sphere(zoo *z, int dim, int r2)               /* exactly cospherical */
{
    int i, j, k, r = (int)sqrt((double)r2) + 1;
    for (i = -r; i <= r; i++) {
        for (j = -r; j <= r; j++) {
            for (k = dim == 3 ? -r : 0; k <= (dim == 3 ? r : 0); k++) {
                if (i * i + j * j + k * k == r2) {
                    zoo_add(z, i, j, k);
                }
            }
        }
    }
}

static inline void zoo_weigh(zoo *z, int kind)
{
    zoo_input *in = zoo_last(z);
    in->weights = (double *)zoo_grow(in->weights, (in->count + 1) * sizeof *in->weights);
    input_fill_weights(kind, in->dim, in->count, 1, in->points, in->weights);
}

/* --- the rooms of the zoo --- */

static inline void zoo_fill_tiny(zoo *z, int dim)
{
    static const double some[6][3] = { { 0.3, 0.1, 0.7 }, { 0.9, 0.2, 0.1 }, { 0.4, 0.8, 0.3 }, { 0.1, 0.6, 0.9 },
                                       { 0.7, 0.5, 0.6 }, { 0.2, 0.9, 0.8 } };
    int n, i, apexes;
    for (n = 0; n <= 6; n++) {
        zoo_new(z, dim, "%d points", n);
        for (i = 0; i < n; i++) {
            zoo_add(z, some[i][0], some[i][1], some[i][2]);
        }
    }
    zoo_new(z, dim, "2 identical points"), zoo_add(z, 1, 2, 3), zoo_repeat(z, 2);
    zoo_new(z, dim, "9 identical points"), zoo_add(z, 1, 2, 3), zoo_repeat(z, 9);
    zoo_new(z, dim, "2 places"), zoo_add(z, 1, 2, 3), zoo_add(z, 1, 2, 4), zoo_add(z, -5, 1, 4), zoo_repeat(z, 4);
    zoo_new(z, dim, "simplex, every point 3 times");
    zoo_add(z, 0, 0, 0), zoo_add(z, 1, 0, 0), zoo_add(z, 0, 1, 0), zoo_add(z, 0, 0, 1), zoo_repeat(z, 3);
    zoo_last(z)->count -= dim == 2;
    for (n = 0; n <= 3; n++) {
        zoo_new(z, dim, "collinear 20, and %d others", n);
        for (i = 0; i < 20; i++) {
            zoo_add(z, i, 2 * i, 3 * i);
        }
        for (i = 0; i < n; i++) {
            zoo_add(z, 5.5 + i, 1.25 * i, 7 - i * i);
        }
        zoo_copy(z, "shuffled"), zoo_shuffle(z);
    }
    zoo_new(z, dim, "collinear 15, every point twice");
    for (i = 0; i < 15; i++) {
        zoo_add(z, 3 * i, -i, i);
    }
    zoo_repeat(z, 2), zoo_shuffle(z);
    zoo_new(z, dim, "collinear 40, rounded");
    for (i = 0; i < 40; i++) {
        zoo_add(z, 0.1 * i, 0.3 * i, 0.7 * i);
    }
    zoo_copy(z, "an ulp off"), zoo_nudge(z);
    for (n = 0; n < 6 && dim == 3; n++) {
        static const char *const names[6] = { "random, z = 0", "lattice, z = 0", "lattice, x + y + z = 24",
                                              "lattice, tilted and rounded", "lattice, an ulp off", "circle, z = 0" };
        for (apexes = 0; apexes <= 2; apexes++) {
            zoo_new(z, 3, "coplanar %s, %d apexes", names[n], apexes);
            if (n == 0) {
                for (i = 0; i < 30; i++) {
                    double x = input_uniform(&z->state);
                    zoo_add(z, x, input_uniform(&z->state), 0);
                }
            } else if (n == 5) {
                zoo_integer_sphere(z, 2, 325);
            } else {
                zoo_grid(z, 6, 6, 1, 2);
                for (i = 0; i < 36 && n == 2; i++) {
                    double *p = zoo_last(z)->points + 3 * i;
                    p[2] = 24 - p[0] - p[1];
                }
                if (n == 3) {
                    zoo_tilt(z, 0.0371);
                } else if (n == 4) {
                    zoo_scale(z, 0.1, 0.3), zoo_nudge(z);
                }
            }
            for (i = 0; i < apexes; i++) {
                zoo_add(z, 3, 3.5, i == 0 ? 30 : -30);
            }
        }
    }
}

static inline void zoo_fill_solids(zoo *z)
{
    static const int pairs[4] = { -1, 1, -1, 1 };
    const double golden = (1 + sqrt(5.0)) / 2;
    double c, s;
    int i, j, n;
    for (n = 4; n <= 16; n *= 2) {
        zoo_new(z, 2, "regular polygon, %d corners", n), zoo_ring(z, n, 1, 0), zoo_known(z, (size_t)n - 2);
        zoo_copy(z, "and centre"), zoo_add(z, 0, 0, 0), zoo_known(z, (size_t)n);
    }
    zoo_new(z, 2, "square and centre"), zoo_grid(z, 2, 2, 1, 2), zoo_add(z, 1, 1, 0), zoo_known(z, 4);
    zoo_new(z, 3, "cube"), zoo_grid(z, 2, 2, 2, 2);
    zoo_copy(z, "and centre"), zoo_add(z, 1, 1, 1), zoo_known(z, 12);
    zoo_copy(z, "and 6 outside: rhombic");
    for (i = 0; i < 3; i++) {
        zoo_add(z, i == 0 ? 3 : 1, i == 1 ? 3 : 1, i == 2 ? 3 : 1);
        zoo_add(z, i == 0 ? -1 : 1, i == 1 ? -1 : 1, i == 2 ? -1 : 1);
    }
    zoo_known(z, 24);
    zoo_new(z, 3, "octahedron");
    for (i = 0; i < 6; i++) {
        int one = i % 2 == 0 ? 1 : -1;
        zoo_add(z, i / 2 == 0 ? one : 0, i / 2 == 1 ? one : 0, i / 2 == 2 ? one : 0);
    }
    zoo_known(z, 4);
    zoo_copy(z, "and centre"), zoo_add(z, 0, 0, 0), zoo_known(z, 8);
    zoo_copy(z, "and 3 others"), zoo_add(z, 0.5, 0, 0), zoo_add(z, 0, 0.5, 0.5), zoo_add(z, 2, 0, 0), zoo_known(z, 0);
    for (n = 0; n < 2; n++) {
        zoo_new(z, 3, n == 0 ? "icosahedron" : "dodecahedron");
        for (i = 0; i < 4; i++) {
            double x = pairs[i], y = i / 2 ? golden : -golden, q = n == 0 ? 0 : 1 / golden;
            zoo_add(z, q * x, n == 0 ? x : y, n == 0 ? y : 0);
            zoo_add(z, n == 0 ? x : y, n == 0 ? y : 0, q * x);
            zoo_add(z, n == 0 ? y : 0, q * x, n == 0 ? x : y);
        }
        for (i = 0; i < 8 && n == 1; i++) {
            zoo_add(z, i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
        }
    }
    for (n = 5; n <= 65; n *= 13) {
        zoo_new(z, 3, "cone over a ring of %d", n), zoo_ring(z, n, 1, 0), zoo_add(z, 0, 0, 1);
        zoo_known(z, (size_t)n - 2);
        zoo_new(z, 3, "spindle over a ring of %d", n), zoo_ring(z, n, 1, 0);
        zoo_add(z, 0, 0, 1), zoo_add(z, 0, 0, -1);
        zoo_new(z, 3, "prism over a ring of %d", n), zoo_ring(z, n, 1, 0), zoo_ring(z, n, 1, 1);
        zoo_new(z, 3, "antiprism over a ring of %d", n), zoo_ring(z, n, 1, 0);
        for (j = 0; j < n; j++) {
            input_turn((j + 0.5) / n, &c, &s);
            zoo_add(z, c, s, 1);
        }
    }
}

static inline void zoo_lattice(zoo *z, int dim, const char *name, int n, int each, const double basis[9],
                               const double offsets[][3])
{
    int i, j, k, m;
    zoo_new(z, dim, "lattice %s", name);
    for (i = 0; i < n; i++) {
        for (j = 0; j < n; j++) {
            for (k = 0; k < (dim == 3 ? n : 1); k++) {
                for (m = 0; m < each; m++) {
                    double x = i + offsets[m][0], y = j + offsets[m][1], w = k + offsets[m][2];
                    zoo_add(z, x * basis[0] + y * basis[3] + w * basis[6], x * basis[1] + y * basis[4] + w * basis[7],
                            x * basis[2] + y * basis[5] + w * basis[8]);
                }
            }
        }
    }
}

static inline void zoo_fill_lattices(zoo *z, int dim)
{
    static const double cubic[9] = { 2, 0, 0, 0, 2, 0, 0, 0, 2 };
    static const double sheared[9] = { 8, 0, 0, 4, 7, 0, 4, 2, 6 };         /* nearly hexagonal, but in integers */
    const double hexagonal[9] = { 1, 0, 0, 0.5, sqrt(0.75), 0, 0, 0, sqrt(8.0 / 3) };
    static const double corner[8][3] = { { 0, 0, 0 }, { 0.5, 0.5, 0.5 } };
    static const double faces[8][3] = { { 0, 0, 0 }, { 0.5, 0.5, 0 }, { 0.5, 0, 0.5 }, { 0, 0.5, 0.5 } };
    static const double diamond[8][3] = { { 0, 0, 0 }, { 0.5, 0.5, 0 }, { 0.5, 0, 0.5 }, { 0, 0.5, 0.5 },
                                          { 0.25, 0.25, 0.25 }, { 0.75, 0.75, 0.25 }, { 0.75, 0.25, 0.75 },
                                          { 0.25, 0.75, 0.75 } };
    static const double close[8][3] = { { 0, 0, 0 }, { 1.0 / 3, 1.0 / 3, 0.5 } };
    static const double turns[4] = { 0.01, 0.125, 0.0797, 1.0 / 12 };
    int n = dim == 2 ? 20 : 8, i, j, k;
    zoo_new(z, dim, "lattice, sorted"), zoo_grid(z, n, n, dim == 3 ? n : 1, 1);
    zoo_known(z, dim == 2 ? 2u * 19 * 19 : 0);
    zoo_copy(z, "shuffled"), zoo_shuffle(z);
    zoo_copy(z, "step 0.1"), zoo_scale(z, 0.1, 0);
    zoo_copy(z, "offset 1000.3"), zoo_scale(z, 1, 1000.3);
    zoo_copy(z, "rounded to float"), zoo_to_float(z);
    for (i = 0; i < 4; i++) {
        zoo_new(z, dim, "lattice, tilted by %.4f turns", turns[i]);
        zoo_grid(z, n, n, dim == 3 ? n : 1, 1), zoo_tilt(z, turns[i]), zoo_shuffle(z);
    }
    zoo_lattice(z, dim, "body centred", dim == 2 ? 14 : 6, 2, cubic, corner);
    zoo_lattice(z, dim, "sheared", n, 1, sheared, corner);
    zoo_lattice(z, dim, "hexagonal, rounded", n, 1, hexagonal, corner);
    if (dim == 3) {
        zoo_lattice(z, dim, "face centred", 5, 4, cubic, faces);
        zoo_lattice(z, dim, "diamond", 4, 8, cubic, diamond);
        zoo_lattice(z, dim, "close packed, rounded", 6, 2, hexagonal, close);
    }
    zoo_new(z, dim, "lattice, flat box"), zoo_grid(z, 20, dim == 2 ? 3 : 20, dim == 3 ? 2 : 1, 1), zoo_shuffle(z);
    zoo_new(z, dim, "lattice, thin rod"), zoo_grid(z, 150, 2, dim == 3 ? 2 : 1, 1), zoo_shuffle(z);
    zoo_new(z, dim, "lattice, half of it, at random"), zoo_grid(z, 24, dim == 2 ? 24 : 8, dim == 3 ? 4 : 1, 1);
    zoo_shuffle(z), zoo_last(z)->count /= 2;
    zoo_new(z, dim, "fractal subset of a lattice");
    for (i = 0; i < 27; i++) {
        for (j = 0; j < 27; j++) {
            for (k = 0; k < (dim == 3 ? 9 : 1); k++) {
                int x = i, y = j, w = k, kept = 1;
                for (; (x | y | w) != 0; x /= 3, y /= 3, w /= 3) {
                    kept &= (x % 3 == 1) + (y % 3 == 1) + (w % 3 == 1) < 2;
                }
                if (kept && (dim == 2 || i < 9)) {
                    zoo_add(z, i, j, k);
                }
            }
        }
    }
    zoo_new(z, dim, "lattice, with its cells' centres at random"), zoo_grid(z, 8, 8, dim == 3 ? 4 : 1, 2);
    for (i = 0; i < 64; i++) {
        uint32_t cell = input_below(&z->state, 7 * 7 * 3);
        zoo_add(z, 1 + 2 * (cell % 7), 1 + 2 * (cell / 7 % 7), 1 + 2 * (cell / 49));
    }
    zoo_new(z, dim, "corners of a power of two cube, nested");
    for (i = 0; i < 10; i++) {
        for (j = 0; j < (dim == 3 ? 8 : 4); j++) {
            double r = ldexp(1, i);
            zoo_add(z, j & 1 ? r : -r, j & 2 ? r : -r, j & 4 ? r : -r);
        }
    }
}

static inline void zoo_fill_round(zoo *z, int dim)
{
    static const int r2[2][3] = { { 325, 5525, 27625 }, { 41, 101, 1001 } };
    int i;
    for (i = 0; i < 3; i++) {
        zoo_new(z, dim, "integer sphere, squared radius %d", r2[dim - 2][i]);
        zoo_integer_sphere(z, dim, r2[dim - 2][i]);
        if (dim == 2) {
            zoo_known(z, zoo_last(z)->count - 2);
        }
    }
    zoo_copy(z, "shuffled"), zoo_shuffle(z);
    zoo_copy(z, "an ulp off"), zoo_nudge(z);
    zoo_new(z, dim, "integer sphere, 1/10"), zoo_integer_sphere(z, dim, r2[dim - 2][1]), zoo_scale(z, 0.1, 0);
    zoo_copy(z, "and centre"), zoo_add(z, 0, 0, 0);
    zoo_new(z, dim, "integer sphere, offset 2^40"), zoo_integer_sphere(z, dim, r2[dim - 2][1]);
    zoo_scale(z, 1, 1099511627776.0);
    zoo_new(z, dim, "integer spheres, concentric");
    for (i = 1; i <= 9; i++) {
        zoo_integer_sphere(z, dim, i * i * 25);
    }
    zoo_new(z, dim, "integer spheres, two that touch"), zoo_integer_sphere(z, dim, 25);
    for (i = (int)zoo_last(z)->count - 1; i >= 0; i--) {
        const double *p = zoo_last(z)->points + i * dim;
        double x = p[0] + 10, y = p[1], w = dim == 3 ? p[2] : 0;
        zoo_add(z, x, y, w);
    }
    zoo_kind(z, dim, INPUT_SPHERE, 500);
    zoo_copy(z, "rounded to float"), zoo_to_float(z);
    zoo_copy(z, "offset 1000"), zoo_scale(z, 1, 1000);
    zoo_copy(z, "and centre"), zoo_add(z, 1000, 1000, 1000);
    if (dim == 3) {
        zoo_new(z, 3, "cylinder, rounded");
        for (i = 0; i < 12; i++) {
            zoo_ring(z, 24, 5, i * 0.7);
        }
        zoo_new(z, 3, "rings on a cone");
        for (i = 1; i < 10; i++) {
            zoo_ring(z, 20, i, i);
        }
        zoo_new(z, 3, "torus, rounded");
        for (i = 0; i < 24; i++) {
            double c, s;
            input_turn(i / 24.0, &c, &s);
            zoo_ring(z, 24, 3 + c, s);
        }
        zoo_new(z, 3, "latitudes and longitudes");
        zoo_add(z, 0, 0, 1), zoo_add(z, 0, 0, -1);
        for (i = 1; i < 16; i++) {
            double c, s;
            input_turn(i / 32.0, &c, &s);
            zoo_ring(z, 32, s, c);
        }
    }
}

static inline void zoo_fill_quadratic(zoo *z)
{
    double c, s;
    int i, n;
    for (n = 10; n <= 160; n *= 4) {
        zoo_kind(z, 3, INPUT_MOMENT, (size_t)n), zoo_known(z, (size_t)((n - 2) * (n - 3) / 2));
        zoo_kind(z, 2, INPUT_MOMENT, (size_t)n), zoo_known(z, (size_t)n - 2);
    }
    zoo_new(z, 3, "skew lines, 2 x 40");
    for (i = 0; i < 40; i++) {
        zoo_add(z, i, 0, 0), zoo_add(z, 0.5, i - 20, 10);
    }
    zoo_known(z, 39 * 39);
    zoo_copy(z, "an ulp off"), zoo_nudge(z);
    zoo_new(z, 3, "linked circles, 2 x 40"), zoo_ring(z, 40, 1, 0);
    for (i = 0; i < 40; i++) {
        input_turn(i / 40.0, &c, &s);
        zoo_add(z, 1 + c, 0, s);
    }
    zoo_new(z, 3, "helices, 2 x 60");
    for (i = 0; i < 60; i++) {
        input_turn(i / 15.0, &c, &s);
        zoo_add(z, c, s, 0.05 * i), zoo_add(z, 2 - c, -s, 0.05 * i);
    }
    for (n = -1; n <= 1; n += 2) {
        zoo_new(z, 3, n == 1 ? "paraboloid" : "saddle");
        for (i = 0; i < 144; i++) {
            double x = i % 12 - 5.5, y = (double)(i / 12) - 5.5;
            zoo_add(z, x, y, x * x + n * y * y);
        }
    }
    for (n = 2; n <= 3; n++) {
        zoo_new(z, n, "parallel lines, 2 x 30");
        for (i = 0; i < 30; i++) {
            zoo_add(z, i, 0, 0), zoo_add(z, i, 1, 0);
        }
        zoo_add(z, 14.5, 0.5, 20);
        zoo_new(z, n, "parabola");
        for (i = -20; i <= 20; i++) {
            zoo_add(z, i, i * i, i % 2);
        }
    }
}

static inline void zoo_fill_ulps(zoo *z, int dim)
{
    static const double far[3][3] = { { 12, 12, 12 }, { 24, 24, 24 }, { 17.3, 17.3, 17.3 } };
    int n = dim == 2 ? 16 : 5, i;
    for (i = 0; i < 3; i++) {                   /* Kettner, Mehlhorn, Pion, Schirra and Yap 2008, figure 2 */
        zoo_new(z, dim, "ulp grid at %s", i == 0 ? "0.5" : i == 1 ? "0.50000000000002531" : "2^52");
        zoo_grid(z, n, n, dim == 3 ? n : 1, i < 2 ? ldexp(1, -53) : 1);
        zoo_scale(z, 1, i == 0 ? 0.5 : i == 1 ? 0.50000000000002531 : 4503599627370496.0);
        zoo_add(z, far[0][0], far[0][1], far[0][2]), zoo_add(z, far[1][0], far[1][1], far[1][2]);
        zoo_add(z, far[2][0], far[2][1], far[2][2]);
        zoo_copy(z, "shuffled"), zoo_shuffle(z);
    }
    zoo_new(z, dim, "every point thrice, an ulp off"), zoo_random(z, 60, 1), zoo_repeat(z, 3), zoo_nudge(z);
    zoo_new(z, dim, "both zeros"), zoo_grid(z, 3, 3, dim == 3 ? 3 : 1, 1), zoo_scale(z, 1, -1), zoo_repeat(z, 3);
    for (i = 0; i < (int)zoo_last(z)->count * dim; i++) {
        double *x = zoo_last(z)->points + i;
        *x = *x == 0 && input_below(&z->state, 2) ? -0.0 : *x;
    }
    zoo_new(z, dim, "powers of two, one line and its mirror");
    for (i = -26; i < 26; i++) {
        zoo_add(z, ldexp(1, i), ldexp(1, -i), i & 1 ? 1 : 0);
    }
}

static inline void zoo_fill_scales(zoo *z, int dim)
{
    static const double offsets[4] = { 1e6, 1e15, 9007199254740992.0, -4.5e18 };
    static const int powers[4] = { 200, -200, 330, -330 };
    int i, j;
    zoo_new(z, dim, "clusters of ever smaller scale");
    for (i = 0; i < 30; i++) {
        zoo_random(z, 8, ldexp(1, -i));
    }
    zoo_new(z, dim, "clusters 1e9 apart");
    for (i = 0; i < 8; i++) {
        size_t from = zoo_last(z)->count;
        zoo_random(z, 20, 1);
        for (j = 0; j < 20 * dim; j++) {
            zoo_last(z)->points[from * (size_t)dim + (size_t)j] += (i >> (j % dim) & 1) * 1e9;
        }
    }
    for (i = 0; i < 4; i++) {
        zoo_new(z, dim, "lattice, offset %g", offsets[i]);
        zoo_grid(z, 6, 6, dim == 3 ? 6 : 1, i == 3 ? 1024 : 4), zoo_scale(z, 1, offsets[i]);
        zoo_new(z, dim, "random, offset %g", offsets[i]), zoo_random(z, 150, 100), zoo_scale(z, 1, offsets[i]);
        zoo_new(z, dim, "random, times 2^%d", powers[i]), zoo_random(z, 100, 1), zoo_scale(z, ldexp(1, powers[i]), 0);
    }
    for (i = 0; i < 2; i++) {
        zoo_new(z, dim, "one axis times 1e%s12", i == 0 ? "+" : "-"), zoo_random(z, 150, 1);
        for (j = 0; j < 150; j++) {
            zoo_last(z)->points[j * dim + 1] *= i == 0 ? 1e12 : 1e-12;
        }
    }
}

static inline void zoo_fill_applications(zoo *z)
{
    double c, s;
    int i, j, k;
    for (k = 2; k <= 3; k++) {
        zoo_new(z, k, "laser scan, quantised rows");
        for (i = 0; i < 800; i++) {
            zoo_add(z, 500000 + 0.25 * (i % 40), 4100000 + 0.5 * (i / 40), 0.01 * input_below(&z->state, 300));
        }
        zoo_new(z, k, "sorted by x");
        for (i = 0; i < 300; i++) {
            double y = input_uniform(&z->state);
            zoo_add(z, i / 300.0, y, input_uniform(&z->state));
        }
    }
    zoo_new(z, 3, "turning scanner");
    for (i = 0; i < 10; i++) {
        for (j = 0; j < 60; j++) {
            input_turn(j / 60.0, &c, &s);
            zoo_add(z, 0.001 * (int)((4000 + 100 * i) * c), 0.001 * (int)((4000 + 100 * i) * s), 0.2 * i);
        }
    }
    zoo_new(z, 3, "box with a hole, as CAD writes it");
    for (k = 0; k < 2; k++) {
        for (i = 0; i <= 10; i++) {
            zoo_add(z, i, 0, k * 4.0), zoo_add(z, i, 10, k * 4.0);
            zoo_add(z, 0, i, k * 4.0), zoo_add(z, 10, i, k * 4.0);
        }
        for (i = 0; i < 32; i++) {
            input_turn(i / 32.0, &c, &s);
            zoo_add(z, 5 + 2 * c, 5 + 2 * s, k * 4.0);
        }
    }
    zoo_new(z, 2, "random, every point 4 times"), zoo_random(z, 80, 1), zoo_repeat(z, 4), zoo_shuffle(z);
    zoo_new(z, 3, "random, every point 4 times"), zoo_random(z, 80, 1), zoo_repeat(z, 4), zoo_shuffle(z);
    zoo_new(z, 2, "contour lines");
    for (i = 1; i < 12; i++) {
        zoo_ring(z, 12 * i, 0.5 * i * i, 0);
    }
    zoo_new(z, 3, "terrain");
    for (i = 0; i < 20; i++) {
        for (j = 0; j < 20; j++) {
            input_turn(i / 17.0, &c, &s);
            zoo_add(z, 30 * i, 30 * j, c * j + s * 5);
        }
    }
    zoo_new(z, 2, "two points at 1e38 and some near zero");
    zoo_add(z, 1, 1e38, 0), zoo_add(z, 2, 1e38, 0), zoo_add(z, 0, 0, 0), zoo_add(z, 3, 1, 0), zoo_add(z, 2, 5, 0);
    for (i = 2; i <= 3; i++) {
        for (j = 0; j < INPUT_KINDS; j++) {
            if (j != INPUT_SPHERE && j != INPUT_MOMENT) {
                zoo_kind(z, i, j, 1000);
            }
        }
    }
}

static inline void zoo_fill_weights(zoo *z, int dim)
{
    int kind, base;
    for (kind = 0; kind < INPUT_WEIGHTS_KINDS; kind++) {
        for (base = 0; base < 2; base++) {
            zoo_new(z, dim, "%s, weights %s", base == 0 ? "random" : "lattice", input_weights_name(kind));
            if (base == 0) {
                zoo_random(z, 120, 1);
            } else {
                zoo_grid(z, dim == 2 ? 11 : 5, dim == 2 ? 11 : 5, dim == 3 ? 5 : 1, 2), zoo_shuffle(z);
            }
            zoo_weigh(z, kind);
        }
    }
    zoo_new(z, dim, "weights tied at one place"), zoo_random(z, 30, 1), zoo_repeat(z, 4), zoo_shuffle(z);
    zoo_weigh(z, INPUT_WEIGHTS_LEVELS);
    zoo_new(z, dim, "collinear, weighted");
    for (base = 0; base < 12; base++) {
        zoo_add(z, base, 2 * base, -base);
    }
    zoo_weigh(z, INPUT_WEIGHTS_HALF);
    zoo_new(z, dim, "sphere, weights |p|^2"), zoo_integer_sphere(z, dim, dim == 2 ? 325 : 41), zoo_add(z, 0, 0, 0);
    zoo_weigh(z, INPUT_WEIGHTS_FLAT);
    for (base = 0; base < 3; base++) {
        static const double values[3] = { 1e300, -1e300, 5e-324 };
        zoo_new(z, dim, "weights %g, half of them", values[base]), zoo_random(z, 24, 1);
        zoo_weigh(z, INPUT_WEIGHTS_ZERO);
        for (kind = 0; kind < 24; kind += 2) {
            zoo_last(z)->weights[kind] = values[base];
        }
    }
}

static inline void zoo_fill_extremes(zoo *z, int dim)
{
    static const double scales[8] = { 1e60, 1e-60, 1e120, 1e-120, 1e150, 1e-160, 1e300, 1e-300 };
    int i, j, n = dim == 2 ? 40 : 30;
    for (i = 0; i < 8; i++) {
        zoo_new(z, dim, "random, times %g", scales[i]), zoo_random(z, (size_t)n, 1), zoo_scale(z, scales[i], 0);
        zoo_new(z, dim, "lattice, times %g", scales[i]), zoo_grid(z, 4, 4, dim == 3 ? 3 : 1, scales[i]);
    }
    zoo_new(z, dim, "denormal lattice"), zoo_grid(z, 5, 5, dim == 3 ? 3 : 1, 5e-324);
    zoo_new(z, dim, "denormals"), zoo_random(z, (size_t)n, 1e-310);
    zoo_new(z, dim, "corners of DBL_MAX, and the middle");
    for (j = 0; j < (dim == 3 ? 8 : 4); j++) {
        zoo_add(z, j & 1 ? DBL_MAX : -DBL_MAX, j & 2 ? DBL_MAX : -DBL_MAX, j & 4 ? DBL_MAX : -DBL_MAX);
    }
    zoo_copy(z, "a little"), zoo_random(z, 10, 1);
    zoo_copy(z, "and tiny"), zoo_random(z, 10, 1e-300);
    for (i = 0; i < 3; i++) {
        int range = i == 0 ? 60 : i == 1 ? 400 : 1000;
        zoo_new(z, dim, "exponents mixed, 2^-%d to 2^%d", range, range);
        zoo_random(z, (size_t)n, 2), zoo_scale(z, 1, -1);
        for (j = 0; j < n * dim; j++) {
            double *x = zoo_last(z)->points + j;
            *x = ldexp(*x, (int)input_below(&z->state, 2u * (uint32_t)range) - range);
        }
        zoo_copy(z, "weighted"), zoo_weigh(z, INPUT_WEIGHTS_HUGE);
    }
}

static inline void zoo_fill_not_finite(zoo *z, int dim)
{
    static const char *const names[3] = { "NaN", "infinity", "-infinity" };
    int what, where;
    for (what = 0; what < 3; what++) {
        double bad = what == 0 ? NAN : what == 1 ? INFINITY : -INFINITY;
        for (where = 0; where < 4; where++) {
            zoo_new(z, dim, "%s %s", names[what],
                    where == 0 ? "first" : where == 1 ? "in the middle" : where == 2 ? "last" : "in a weight");
            zoo_random(z, 10, 1);
            zoo_last(z)->finite = 0;
            if (where == 3) {
                zoo_weigh(z, INPUT_WEIGHTS_SMALL);
                zoo_last(z)->weights[7] = bad;
            } else {
                zoo_last(z)->points[where == 0 ? 0 : where == 1 ? 5 * dim + 1 : 10 * dim - 1] = bad;
            }
        }
    }
}

static inline void zoo_fill(zoo *z)
{
    int dim;
    memset(z, 0, sizeof *z);
    z->state = 20;
    for (dim = 2; dim <= 3; dim++) {
        zoo_fill_tiny(z, dim);
        zoo_fill_lattices(z, dim);
        zoo_fill_round(z, dim);
        zoo_fill_ulps(z, dim);
        zoo_fill_scales(z, dim);
        zoo_fill_weights(z, dim);
        zoo_fill_extremes(z, dim);
        zoo_fill_not_finite(z, dim);
    }
    zoo_fill_solids(z);
    zoo_fill_quadratic(z);
    zoo_fill_applications(z);
}

static inline void zoo_free(zoo *z)
{
    size_t i;
    for (i = 0; i < z->count; i++) {
        free(z->items[i].points);
        free(z->items[i].weights);
    }
    free(z->items);
    memset(z, 0, sizeof *z);
}

#if defined(__clang__)
#pragma STDC FP_CONTRACT DEFAULT
#elif defined(__GNUC__)
#pragma GCC pop_options
#endif

#endif
