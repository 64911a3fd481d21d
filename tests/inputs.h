/* inputs.h: the kinds of points and weights of the tests and benchmarks; C99 and C++.

   Only IEEE operations and our own random numbers are used, so every machine and compiler makes the same points.

       double *points = (double *)malloc(n * 3 * sizeof *points);
       input_fill(INPUT_SPHERE, 3, n, 1, points);                   // seed 1
       input_fill_weights(INPUT_WEIGHTS_HIDING, 3, n, 1, points, weights); */
#ifndef INPUTS_H
#define INPUTS_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* No fused multiply-add: -march=native must not change the points. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif

#define INPUT_TURN 6.283185307179586                /* 2 pi */

enum {
    INPUT_UNIFORM,          /* in the unit cube */
    INPUT_GAUSS,            /* normal, sigma 1 */
    INPUT_BALL,             /* uniform in the unit ball */
    INPUT_SPHERE,           /* on the unit sphere, rounded: nearly but not exactly cospherical */
    INPUT_CLUSTERS,         /* 64 Gaussians, sigma 1e-2 to 1e-4 */
    INPUT_LATTICE,          /* the first n points of an integer lattice, shuffled: fully degenerate */
    INPUT_LINES,            /* 8 random segments, with noise of 1e-5 */
    INPUT_SPIRAL,           /* 20 turns, with noise of 1e-4 */
    INPUT_PLANE,            /* 3D: z = 1e-9 normal; 2D: y = 1e-9 uniform, nearly a line */
    INPUT_ANISOTROPIC,      /* uniform, last axis times 1e-4 */
    INPUT_TERRAIN,          /* an airborne scan of hills of 1 km, in whole centimetres; 2D: without heights */
    INPUT_MOMENT,           /* (t, t^2, t^3), t = 1..n shuffled: (n-2)(n-3)/2 tetrahedra in 3D */
    INPUT_KINDS
};

enum {
    INPUT_WEIGHTS_ZERO,
    INPUT_WEIGHTS_CONSTANT,
    INPUT_WEIGHTS_SMALL,            /* hide nothing: 1e-6 U h^2, h the typical distance, U uniform in [0, 1) */
    INPUT_WEIGHTS_HIDING,           /* 0.2 U h^2 (2D), 0.45 U h^2 (3D): hide one in a hundred uniform points */
    INPUT_WEIGHTS_HALF,             /* 8 U h^2: most are hidden */
    INPUT_WEIGHTS_NEGATIVE,
    INPUT_WEIGHTS_VERY_NEGATIVE,    /* -1e20 of the extent squared, and the points' own small differences */
    INPUT_WEIGHTS_FLAT,             /* |p|^2, rounded: all lifts are (nearly) 0 */
    INPUT_WEIGHTS_FLAT_ULP,         /* the same, some an ulp lower */
    INPUT_WEIGHTS_FLAT_TILTED,      /* |p|^2 minus a plane */
    INPUT_WEIGHTS_CHECKER,          /* 0 and h^2 / 2 by the parity of the cell */
    INPUT_WEIGHTS_GIANT,            /* one of 1e6 times the extent squared, the others 0: it hides what it can */
    INPUT_WEIGHTS_LEVELS,           /* 0, h^2, 2 h^2 at random: many ties */
    INPUT_WEIGHTS_HUGE,             /* up to 1e300 of either sign */
    INPUT_WEIGHTS_KINDS
};

static inline const char *input_name(int kind)
{
    static const char *const names[INPUT_KINDS] = { "uniform", "gauss", "ball", "sphere", "clusters", "lattice",
                                                    "lines", "spiral", "plane", "anisotropic", "terrain",
                                                    "moment" };
    return names[kind];
}

static inline const char *input_weights_name(int kind)
{
    static const char *const names[INPUT_WEIGHTS_KINDS] = {
        "zero", "constant", "small", "hiding", "half", "negative", "very negative", "flat", "flat ulp", "flat tilted",
        "checker", "giant", "levels", "huge" };
    return names[kind];
}

/* splitmix64 (Steele, Lea and Flood 2014) */
static inline uint64_t input_next(uint64_t *state)
{
    uint64_t x = *state += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static inline uint32_t input_below(uint64_t *state, uint32_t n)              /* 0..n-1 */
{
    return (uint32_t)(((input_next(state) >> 32) * n) >> 32);
}

static inline double input_uniform(uint64_t *state)                          /* [0, 1), multiples of 2^-53 */
{
    return (double)(input_next(state) >> 11) * (1.0 / 9007199254740992.0);
}

/* The point (c, s) of the unit circle after t turns, by Taylor series within an eighth of a turn. */
static inline void input_turn(double t, double *c, double *s)
{
    double quarters = t * 4, whole = (double)(int64_t)(quarters + (quarters < 0 ? -0.5 : 0.5));
    double x = (t - whole * 0.25) * INPUT_TURN, x2 = x * x, cosine = 1, sine = 1;
    int k;
    for (k = 18; k > 0; k -= 2) {
        cosine = 1 - cosine * x2 / (k * (k - 1));
        sine = 1 - sine * x2 / (k * (k + 1));
    }
    sine *= x;
    switch ((int64_t)whole & 3) {
    case 0: *c = cosine, *s = sine; break;
    case 1: *c = -sine, *s = cosine; break;
    case 2: *c = -cosine, *s = -sine; break;
    default: *c = sine, *s = -cosine; break;
    }
}

/* Normal, by the polar method; ln x = 2 artanh((x-1)/(x+1)) after x is halved or doubled into [0.7, 1.42]. */
static inline double input_gauss(uint64_t *state)
{
    double u, v, r, x, z, z2, ln, sum = 0;
    int exponent = 0, k;
    do {
        u = 2 * input_uniform(state) - 1;
        v = 2 * input_uniform(state) - 1;
        r = u * u + v * v;
    } while (r >= 1 || r < 1e-300);
    for (x = r; x < 0.7; x *= 2) {
        exponent--;
    }
    z = (x - 1) / (x + 1);
    z2 = z * z;
    for (k = 23; k > 0; k -= 2) {
        sum = sum * z2 + 1.0 / k;
    }
    ln = 2 * z * sum + exponent * 0.6931471805599453;
    return u * sqrt(-2 * ln / r);
}

static inline void input_shuffle(int dim, size_t n, uint64_t *state, double *points)
{
    size_t i;
    for (i = n; i > 1; i--) {
        size_t j = (size_t)(input_next(state) % i);
        double swap[3];
        memcpy(swap, points + (i - 1) * (size_t)dim, (size_t)dim * sizeof *swap);
        memcpy(points + (i - 1) * (size_t)dim, points + j * (size_t)dim, (size_t)dim * sizeof *swap);
        memcpy(points + j * (size_t)dim, swap, (size_t)dim * sizeof *swap);
    }
}

static inline size_t input_side(int dim, size_t n)                           /* smallest k with k^dim >= n */
{
    size_t k = 1;
    while ((dim == 2 ? k * k : k * k * k) < n) {
        k++;
    }
    return k;
}

/* One point of a kind that knows no others; table: 64 segments, or centres and sigmas of clusters. */
static inline void input_point(int kind, int dim, const double table[64][7], uint64_t *state, double *p)
{
    double r2, t, c, s;
    const double *row;
    int j;
    switch (kind) {
    case INPUT_GAUSS:
        for (j = 0; j < dim; j++) {
            p[j] = input_gauss(state);
        }
        break;
    case INPUT_BALL:
    case INPUT_SPHERE:
        do {
            for (r2 = 0, j = 0; j < dim; j++) {
                p[j] = 2 * input_uniform(state) - 1;
                r2 += p[j] * p[j];
            }
        } while (r2 > 1 || r2 < 1e-6);
        for (j = 0; j < dim && kind == INPUT_SPHERE; j++) {
            p[j] /= sqrt(r2);
        }
        break;
    case INPUT_CLUSTERS:
        row = table[input_below(state, 64)];
        for (j = 0; j < dim; j++) {
            p[j] = row[j] + row[6] * input_gauss(state);
        }
        break;
    case INPUT_LINES:
        row = table[input_below(state, 8)];
        t = input_uniform(state);
        for (j = 0; j < dim; j++) {
            p[j] = row[j] + t * (row[3 + j] - row[j]) + 1e-5 * input_gauss(state);
        }
        break;
    case INPUT_SPIRAL:
        t = input_uniform(state);
        input_turn(20 * t, &c, &s);
        p[0] = t * c + 1e-4 * input_gauss(state);
        p[1] = t * s + 1e-4 * input_gauss(state);
        if (dim == 3) {
            p[2] = t + 1e-4 * input_gauss(state);
        }
        break;
    case INPUT_TERRAIN:
        for (j = 0; j < 2; j++) {
            p[j] = (double)input_below(state, 100000);
        }
        if (dim == 3) {
            input_turn(p[0] * 3e-5, &c, &s);
            input_turn(p[1] * 7e-5 + c, &t, &r2);
            p[2] = (double)(int64_t)(2000 * (3 + s + t) + 5 * input_uniform(state));
        }
        break;
    default:
        for (j = 0; j < dim; j++) {
            p[j] = input_uniform(state);
        }
        if (kind == INPUT_PLANE) {
            p[dim - 1] = 1e-9 * (dim == 3 ? input_gauss(state) : p[dim - 1]);
        } else if (kind == INPUT_ANISOTROPIC) {
            p[dim - 1] *= 1e-4;
        }
    }
}

/* n points of a kind: dim * n numbers. */
static inline void input_fill(int kind, int dim, size_t n, uint64_t seed, double *points)
{
    uint64_t state = seed;
    double table[64][7], *p = points;
    size_t i, side = input_side(dim, n);
    int j;
    for (i = 0; i < 64; i++) {
        for (j = 0; j < 6; j++) {
            table[i][j] = input_uniform(&state);
        }
        table[i][6] = i % 3 == 0 ? 1e-2 : i % 3 == 1 ? 1e-3 : 1e-4;
    }
    for (i = 0; i < n; i++, p += dim) {
        if (kind == INPUT_LATTICE) {
            size_t rest = i;
            for (j = dim - 1; j >= 0; j--, rest /= side) {
                p[j] = (double)(rest % side);
            }
        } else if (kind == INPUT_MOMENT) {
            for (j = 0; j < dim; j++) {
                p[j] = j == 0 ? (double)(i + 1) : p[j - 1] * p[0];
            }
        } else {
            input_point(kind, dim, (const double (*)[7])table, &state, p);
        }
    }
    if (kind == INPUT_LATTICE || kind == INPUT_MOMENT) {
        input_shuffle(dim, n, &state, points);
    }
}

static inline double input_ulp_lower(double x)                               /* x > 0 */
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits--;
    memcpy(&x, &bits, sizeof bits);
    return x;
}

/* n weights of a kind for those points. */
static inline void input_fill_weights(int kind, int dim, size_t n, uint64_t seed, const double *points,
                                      double *weights)
{
    uint64_t state = seed ^ 0x77656967687473u;
    double low = 0, high = 0, extent, h;
    size_t i;
    int j;
    for (i = 0; i < n * (size_t)dim; i++) {
        low = i == 0 || points[i] < low ? points[i] : low;
        high = i == 0 || points[i] > high ? points[i] : high;
    }
    extent = high > low ? high - low : 1;
    h = extent / (double)input_side(dim, n);
    for (i = 0; i < n; i++) {
        const double *p = points + i * (size_t)dim;
        double u = input_uniform(&state), norm = 0, plane = 0, parity = 0;
        for (j = 0; j < dim; j++) {
            norm += p[j] * p[j];
            plane += (j + 1) * 0.25 * p[j];
            parity += (double)(int64_t)((p[j] - low) / h + 0.5);
        }
        switch (kind) {
        case INPUT_WEIGHTS_ZERO: weights[i] = 0; break;
        case INPUT_WEIGHTS_CONSTANT: weights[i] = 1.5 * h * h; break;
        case INPUT_WEIGHTS_SMALL: weights[i] = 1e-6 * u * h * h; break;
        case INPUT_WEIGHTS_HIDING: weights[i] = (dim == 2 ? 0.2 : 0.45) * u * h * h; break;
        case INPUT_WEIGHTS_HALF: weights[i] = 8 * u * h * h; break;
        case INPUT_WEIGHTS_NEGATIVE: weights[i] = -u * h * h; break;
        case INPUT_WEIGHTS_VERY_NEGATIVE: weights[i] = -1e20 * extent * extent * (1 + 1e-15 * u); break;
        case INPUT_WEIGHTS_FLAT: weights[i] = norm; break;
        case INPUT_WEIGHTS_FLAT_ULP: weights[i] = u < 0.5 && norm > 0 ? input_ulp_lower(norm) : norm; break;
        case INPUT_WEIGHTS_FLAT_TILTED: weights[i] = norm - plane; break;
        case INPUT_WEIGHTS_CHECKER: weights[i] = (int64_t)parity % 2 != 0 ? 0.5 * h * h : 0; break;
        case INPUT_WEIGHTS_GIANT: weights[i] = i == n / 2 ? 1e6 * extent * extent : 0; break;
        case INPUT_WEIGHTS_LEVELS: weights[i] = (double)(int)(3 * u) * h * h; break;
        default: weights[i] = (u - 0.5) * (i % 3 == 0 ? 1e300 : i % 3 == 1 ? 1e150 : 1); break;
        }
    }
}

#if defined(__clang__)
#pragma STDC FP_CONTRACT DEFAULT
#elif defined(__GNUC__)
#pragma GCC pop_options
#endif

#endif
