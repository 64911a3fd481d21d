/* small.h: small awkward inputs from bytes, for random tests and fuzzers: dimension, count, a grid (small integers,
   tenths, mixed exponents, ulps ...), a shape (free, flat, on a line, on a sphere, repeated) and weights; and the
   comparison of pbw's answer with the oracle's.  Include pbw.h before, for small_test
   pbw_check.h. */
#ifndef SMALL_H
#define SMALL_H

#include "oracle.h"
#include <math.h>
#include <stdio.h>

#define SMALL_POINTS 24

typedef struct small_input {
    int dim, count, weighted;
    double points[SMALL_POINTS * 3], weights[SMALL_POINTS];
} small_input;

typedef struct small_bytes { const unsigned char *at; size_t left; } small_bytes;

static inline unsigned small_take(small_bytes *bytes)
{
    return bytes->left == 0 ? 0u : (bytes->left--, *bytes->at++);
}

static inline double small_finite(double x)
{
    return x - x == 0 ? x : 1;
}

/* A number of the grid, of which i is a step in 0..size-1. */
static inline double small_number(int grid, int size, int i, small_bytes *bytes)
{
    double x;
    switch (grid) {
    case 0: case 1: case 2: case 3: return i;
    case 4: return i * 0.1;
    case 5: return i == size / 2 && small_take(bytes) & 1 ? -0.0 : i - size / 2;
    case 6: return ldexp(i - size / 2, (int)(small_take(bytes) % 64) - 32);
    case 7: return ldexp(i - size / 2, (int)(small_take(bytes) % 250) * 8 - 1024);
    case 8: return 1 + ldexp(i, -52);
    case 9: return 9007199254740992.0 + 2 * i;
    case 10: return ldexp(i, -1074);
    case 11: return (i - size / 2) * 1e-3 + 1e6;
    case 12: return i - size / 2 + ldexp((int)(small_take(bytes) % 3) - 1, -50);
    case 13: return ((int)small_take(bytes) - 128) / 64.0;
    case 14: return i + (small_take(bytes) * 256.0 + small_take(bytes)) / 65536;
    default:
        x = 0;
        if (bytes->left >= sizeof x) {
            memcpy(&x, bytes->at, sizeof x);
            bytes->at += sizeof x;
            bytes->left -= sizeof x;
        }
        return small_finite(x);
    }
}

static inline double small_weight(int kind, const double *p, int dim, small_bytes *bytes)
{
    double norm = 0;
    int i = (int)small_take(bytes), j;
    for (j = 0; j < dim; j++) {
        norm += p[j] * p[j];
    }
    switch (kind) {
    case 0: return i % 4;
    case 1: return small_finite(norm);
    case 2: return small_finite(norm - i % 2);
    case 3: return i % 3 - 1;
    case 4: return i * 0.01;
    case 5: return i % 4 == 0 ? -1e300 : i % 4 == 1 ? 1e10 : i % 4 == 2 ? 5e-324 : -0.0;
    case 6: return ldexp(i % 16, (int)(small_take(bytes) % 250) * 8 - 1030);
    default: return i % 2 ? 7 : 7 + ldexp(i, -50);
    }
}

static inline void small_decode(small_input *in, const unsigned char *data, size_t length)
{
    static const double circle[12][3] = { { 3, 4, 0 }, { 4, 3, 0 }, { 5, 0, 0 }, { 4, -3, 0 }, { 3, -4, 0 },
                                          { 0, -5, 0 }, { -3, -4, 0 }, { -4, -3, 0 }, { -5, 0, 0 }, { -4, 3, 0 },
                                          { -3, 4, 0 }, { 0, 5, 0 } };
    small_bytes bytes;
    int a, b, grid, shape, size, kind, i, j;
    bytes.at = data;
    bytes.left = length;
    a = (int)small_take(&bytes);
    b = (int)small_take(&bytes);
    in->dim = 2 + a % 2;
    in->weighted = a / 2 % 2;
    grid = a / 4 % 16;
    shape = b % 8;
    kind = b / 8 % 8;
    size = 2 + (int)(small_take(&bytes) % 5);
    in->count = (int)(small_take(&bytes) % (in->dim == 2 ? 14 : 12));
    in->count += in->count == 11 ? (int)(small_take(&bytes) % (SMALL_POINTS - 14)) : 0;
    if (grid == 7 || grid == 15) {                    /* long integers are slow: few points, and not often */
        in->count = in->count > 7 ? 7 : in->count;
        grid -= small_take(&bytes) % 4 != 0 ? 4 : 0;
    }
    for (i = 0; i < in->count; i++) {
        double *p = in->points + i * in->dim;
        int step = (int)small_take(&bytes), where = (int)small_take(&bytes);
        for (j = 0; j < in->dim; j++) {
            p[j] = small_number(grid, size, (j == 0 ? step : j == 1 ? step / size : where) % size, &bytes);
        }
        if (shape == 1 && in->dim == 3 && i > 1) {                                  /* flat, but for the first two */
            p[2] = grid < 4 ? 6 - p[0] - p[1] : 0;
        } else if (shape == 2 && i > 1 + where % 2) {                               /* on a line */
            p[1] = p[0];
            p[in->dim - 1] = p[0];
        } else if (shape == 3) {                                                    /* on a circle or sphere */
            const double *q = circle[step % 12];
            double scale = grid == 4 ? 0.1 : 1;
            p[0] = scale * q[where % in->dim];
            p[1] = scale * q[(where + 1) % in->dim];
            p[in->dim - 1] = in->dim == 3 ? scale * q[(where + 2) % 3] : p[1];
        } else if (shape == 4 && i > 0 && where % 2) {                              /* a place taken before */
            memcpy(p, in->points + step % i * in->dim, (size_t)in->dim * sizeof *p);
        }
        in->weights[i] = in->weighted ? small_weight(kind, p, in->dim, &bytes) : 0;
    }
}

static inline const double *small_weights(const small_input *in)
{
    return in->weighted ? in->weights : NULL;
}

/* C text of the input, to reproduce a failure. */
static inline void small_print(const small_input *in)
{
    int i;
    printf("    /* %dD, %d points */ double points[] = { ", in->dim, in->count);
    for (i = 0; i < in->count * in->dim; i++) {
        printf("%.17g%s", in->points[i], (i + 1) % in->dim == 0 ? ",  " : ", ");
    }
    printf("};\n");
    for (i = 0; i < in->count && in->weighted; i++) {
        printf("%s%.17g", i == 0 ? "    double weights[] = { " : ", ", in->weights[i]);
    }
    printf("%s", in->weighted && in->count > 0 ? " };\n" : "");
}

#ifdef PBW_CHECK_H
/* Triangulates and judges: by the oracle where the places are few enough, by pbw_check where `check` says so or they
   are not.  NULL, or what is wrong. */
static inline const char *small_test(const small_input *in, const pbw_options *options, int check)
{
    static oracle o;
    pbw_mesh mesh;
    pbw_report report;
    pbw_status status = pbw_triangulate(in->dim, in->points, small_weights(in), (size_t)in->count, options, &mesh);
    const char *fault = NULL;
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        return pbw_status_string(status);
    }
    if (oracle_solve(&o, in->dim, in->count, in->points, small_weights(in), 0)) {
        fault = oracle_judge(&o, in->count, status, &mesh);
    } else {
        check = 1;
    }
    if (fault == NULL && check) {
        status = pbw_check(&mesh, options, &report);
        fault = status != PBW_OK ? pbw_status_string(status) : report.valid ? NULL : report.what;
    }
    pbw_free(&mesh);
    return fault;
}
#endif

#endif
