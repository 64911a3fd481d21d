/* test_predicates.c: every stage of every predicate against exact integers.

       test_predicates [--long] [--time] [options of test.h]      --count N: so many near-degenerate calls a predicate
                                                                   --long: a million; --time: ns a call, no tests

   The truth comes from another method than the header's: no translation, no filter, no minors, but the homogeneous
   determinant of the points (x, y, z, lift, 1) by the permutation formula, in oracle.h's integers.
   test_digits.c has the same tests for digits of 26 bits. */
#ifndef CALLS
#define CALLS 200000
#endif
#define PBW_STATIC                                   /* what is not tested here is not compiled */
#define PBW_IMPLEMENTATION
#include "../pbw.h"
#include "oracle.h"
#include "test.h"

#include <fenv.h>
#include <math.h>
#include <time.h>

/* --- random numbers: splitmix64 --- */

static uint64_t state;

static uint64_t random_bits(void)
{
    uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static int below(int n)
{
    return (int)(random_bits() % (unsigned)n);
}

static double unit_random(void)
{
    return (double)(random_bits() >> 11) * 0x1p-53;
}

static double ulps(double x, int n)                       /* n representable numbers up or down */
{
    for (; n != 0; n += n > 0 ? -1 : 1) {
        double next = nextafter(x, n > 0 ? HUGE_VAL : -HUGE_VAL);
        x = next - next == 0 ? next : x;
    }
    return x;
}

/* --- points: dim+2 records of dim coordinates and a weight, the last point the query --- */

typedef struct points {
    int dim;
    double at[5][4];
} points;

enum { UNIFORM, LATTICE, TENTHS, SURVEY, COSPHERICAL, SPHERE, CAP, FLAT, KETTNER, OFFSET, CLUSTER, MODERATE, FLOATS,
       THIN, COPIES, ZEROS, DENORMAL, MIXED, RANGE, FAINT, FAINT_LATTICE, SCALES, FAMILIES };

static const char *const family_name[FAMILIES] = {
    "uniform", "lattice", "lattice of tenths", "survey grid", "cospherical integers", "rounded to a sphere",
    "rounded to a cap", "rounded to a plane", "ulp grid", "offset 2^53", "clusters", "exponents +-30", "floats",
    "thin", "shared coordinates", "zeros of both signs", "denormals", "exponents +-300", "corners of the range",
    "an axis of denormals", "lattice, an axis of denormals", "lattice, three scales"
};

static double coordinate(int family, int k)
{
    switch (family) {
    case LATTICE: return below(4);
    case TENTHS: return (20 + below(4)) * 0.1;
    case SURVEY: return (500000 + below(40)) + below(1000) / 1024.0;
    case KETTNER: return ulps((1 + below(2)) * (k == 0 ? 12.0 : 0.5), below(33) - 16);
    case OFFSET: return 9007199254740992.0 + 2 * below(5);
    case CLUSTER: return below(3) + 1e-9 * unit_random();
    case MODERATE: return ldexp(unit_random() - 0.5, below(61) - 30);
    case FLOATS: return (double)(float)unit_random();
    case THIN: return unit_random() * (k == 1 ? 1e-12 : 1);
    case ZEROS: return below(2) == 0 ? -0.0 : below(3) - 1;
    case MIXED: return ldexp(unit_random() - 0.5, below(2 * 996 + 1) - 996);
    case DENORMAL: return ldexp(below(9) - 4, -1074 + (below(3) == 0 ? below(60) : 0));
    case FAINT: return k == 1 ? ldexp(unit_random() - 0.5, -1030 - below(45)) : ldexp(unit_random(), 40 * below(2));
    case FAINT_LATTICE: return k == 1 ? (below(5) - 2) * 5e-324 : below(4);
    case SCALES: return (below(5) - 2) * (k == 0 ? 1.0 : k == 1 ? 0x1p-333 : 5e-324);
    case RANGE: return (below(2) == 0 ? 1 : -1) * (below(4) == 0 ? 5e-324 : below(4) == 0 ? 1.0 : DBL_MAX);
    default: return unit_random();
    }
}

/* A point on the sphere of radius 9, in the plane on the circle of radius 65, around an integer centre. */
static void on_integer_sphere(points *p, double *q, const double *centre)
{
    static const double circle[9][2] = { { 65, 0 }, { 63, 16 }, { 60, 25 }, { 56, 33 }, { 52, 39 }, { 39, 52 },
                                         { 33, 56 }, { 25, 60 }, { 16, 63 } };
    static const double sphere[7][3] = { { 9, 0, 0 }, { 8, 4, 1 }, { 7, 4, 4 }, { 6, 6, 3 }, { 4, 1, 8 }, { 1, 8, 4 },
                                         { 3, 6, 6 } };
    int which = below(p->dim == 2 ? 9 : 7), turn = below(3), k;
    for (k = 0; k < p->dim; k++) {
        double x = p->dim == 2 ? circle[which][k] : sphere[which][(k + turn) % 3];
        q[k] = centre[k] + (below(2) == 0 ? x : -x);
    }
}

static void fill_places(points *p, int family)
{
    double centre[3], radius = ldexp(1 + unit_random(), below(9) - 4), size = family == CAP ? 1e-3 : 1;
    int i, k, dim = p->dim;
    for (k = 0; k < 3; k++) {
        centre[k] = family == COSPHERICAL ? below(2000) - 1000 : below(2) == 0 ? 0 : 10 * unit_random();
    }
    for (i = 0; i < dim + 2; i++) {
        double *q = p->at[i], norm = 0;
        for (k = 0; k < dim; k++) {
            q[k] = coordinate(family, k);
        }
        if (family == COSPHERICAL) {
            on_integer_sphere(p, q, centre);
        } else if (family == SPHERE || family == CAP) {
            for (k = 0; k < dim; k++) {
                q[k] = (k == 0 && family == CAP ? 1 : (q[k] - 0.5) * size);
                norm += q[k] * q[k];
            }
            for (k = 0; k < dim; k++) {
                q[k] = centre[k] + q[k] / sqrt(norm) * radius;
            }
        } else if (family == FLAT) {                       /* and on a line, or in 3D sometimes on one */
            q[dim - 1] = 0.3 * q[0] + (dim == 3 ? 0.7 * q[1] : 0) + centre[2];
            if (dim == 3 && below(3) == 0) {
                q[1] = 0.1 + q[0] / 3;
                q[2] = 0.2 - q[0] / 7;
            }
        } else if (family == COPIES && i > 0) {
            for (k = 0; k < dim; k++) {
                q[k] = below(2) == 0 ? ulps(p->at[below(i)][k], below(4) == 0 ? below(5) - 2 : 0) : q[k];
            }
        }
    }
    if (below(3) == 0) {
        for (i = 0; i < dim + 2; i++) {
            k = below(dim);
            p->at[i][k] = ulps(p->at[i][k], below(3) - 1);
        }
    }
}

static double square(const points *p, int i)
{
    double sum = 0;
    int k;
    for (k = 0; k < p->dim; k++) {
        sum += p->at[i][k] * p->at[i][k];
    }
    return sum;
}

/* About the determinant of the rows corner - query without row skip. */
static double cofactor(const points *p, int skip)
{
    double u[4][3] = { { 0 } };
    const double *q = p->at[p->dim + 1];
    int i, k, n = 0;
    for (i = 0; i <= p->dim; i++) {
        for (k = 0; k < p->dim; k++) {
            u[n][k] = p->at[i][k] - q[k];
        }
        n += i != skip;
    }
    if (p->dim == 2) {
        return u[0][0] * u[1][1] - u[0][1] * u[1][0];
    }
    return u[0][0] * (u[1][1] * u[2][2] - u[1][2] * u[2][1]) - u[0][1] * (u[1][0] * u[2][2] - u[1][2] * u[2][0])
        + u[0][2] * (u[1][0] * u[2][1] - u[1][1] * u[2][0]);
}

/* No weights in half of the cases.  A quarter solves for the query's weight: nearly a tie, whatever the points. */
static void fill_weights(points *p)
{
    double sum = 0, whole = 0;
    int i, k, dim = p->dim, kind = below(60), solve = kind >= 15 && kind < 30;
    for (i = 0; i < dim + 2; i++) {
        double s = square(p, i), w = 0;
        switch (kind) {
        case 0: w = -1e300 * below(3); break;
        case 1: w = ldexp(below(9), -1074); break;
        case 2: case 3: case 4: w = 0.1; break;
        case 5: case 6: case 7: w = below(5) * 0.25; break;
        case 8: case 9: case 10: w = s - s == 0 ? ulps(s, below(3) - 1) : 1; break;
        case 11: case 12: case 13: w = (unit_random() - 0.5) * (s - s == 0 ? s : 1); break;
        default: w = kind >= 15 && kind < 20 ? below(5) * 0.25 : 0; break;
        }
        p->at[i][dim] = w;
    }
    for (i = 0; i <= dim && solve; i++) {
        double c = i % 2 == 0 ? cofactor(p, i) : -cofactor(p, i), lift = -p->at[i][dim];
        for (k = 0; k < dim; k++) {
            double u = p->at[i][k] - p->at[dim + 1][k];
            lift += u * u;
        }
        sum -= c * lift;
        whole += c;
    }
    if (solve) {
        sum /= whole;
        p->at[dim + 1][dim] = sum - sum == 0 ? ulps(sum, below(5) - 2) : 0;
    }
}

static void fill(points *p, int dim, int family)
{
    p->dim = dim;
    fill_places(p, family);
    fill_weights(p);
}

/* --- the truth --- */

typedef struct matrix {                                   /* rows (x, y, z, lift, 1); the last column is not stored */
    int size;
    oracle_big entry[5][4];
} matrix;

/* Adds to sum the products of all ways to choose columns for the rows row.., with the signs of the permutations. */
static void add_permutations(oracle_big *sum, const matrix *m, int row, unsigned used, int sign,
                             const oracle_big *product)
{
    int k, inversions = 0;
    if (row == m->size) {
        oracle_add(sum, product, sign);
        return;
    }
    for (k = m->size - 1; k >= 0; k--) {
        if (used >> k & 1) {
            inversions++;                                  /* columns to the right that an earlier row has */
        } else if (k == m->size - 1) {
            add_permutations(sum, m, row + 1, used | 1u << k, sign, product);
        } else if (m->entry[row][k].sign != 0) {
            oracle_big next;
            oracle_multiply(&next, product, &m->entry[row][k]);
            add_permutations(sum, m, row + 1, used | 1u << k, inversions % 2 == 0 ? sign : -sign, &next);
        }
    }
}

/* The determinant of the first dim+1 points, or power: of all with their lifts.  Coordinates are in units of 2^unit,
   lifts of 4^unit; returns the unit.  With raised, lift i is (lift << 320) + (1 << 64 (4 - raised[i])). */
static int true_determinant(const points *p, int power, const int *raised, oracle_big *value)
{
    static matrix m;                                      /* static: too large for a small stack */
    oracle_big one, x;
    int i, k, dim = p->dim, count = dim + 1 + power, unit = 1024;
    for (i = 0; i < count; i++) {
        int lowest = power ? oracle_lowest(p->at[i][dim]) : 1024;
        unit = lowest < 2 * unit ? (int)floor(lowest / 2.0) : unit;
        for (k = 0; k < dim; k++) {
            lowest = oracle_lowest(p->at[i][k]);
            unit = lowest < unit ? lowest : unit;
        }
    }
    m.size = count;
    for (i = 0; i < count; i++) {
        oracle_big *lift = &m.entry[i][dim];
        lift->sign = lift->length = 0;
        for (k = 0; k < dim; k++) {
            oracle_from_double(&m.entry[i][k], p->at[i][k], unit);
            oracle_multiply(&x, &m.entry[i][k], &m.entry[i][k]);
            oracle_add(lift, &x, 1);
        }
        if (power) {
            oracle_from_double(&x, p->at[i][dim], 2 * unit);
            oracle_add(lift, &x, -1);
        }
        if (raised != NULL) {
            oracle_from_double(&one, 1, -320);
            oracle_multiply(&x, lift, &one);
            oracle_set(lift, &x);
            oracle_from_double(&one, 1, -64 * (4 - raised[i]));
            oracle_add(lift, &one, 1);
        }
    }
    oracle_from_double(&one, 1, 0);
    value->sign = value->length = 0;
    add_permutations(value, &m, 0, 0, dim == 2 ? 1 : -1, &one);
    return unit;
}

static int true_sign(const points *p, int power, const int *raised)
{
    oracle_big value;
    true_determinant(p, power, raised, &value);
    return value.sign;
}

/* By how many of the dim+2 points each is lexicographically exceeded; 0 if two are at one place. */
static int find_ranks(const points *p, int *rank)
{
    int i, j, k;
    for (i = 0; i < p->dim + 2; i++) {
        for (rank[i] = j = 0; j < p->dim + 2; j++) {
            for (k = 0; k < p->dim && p->at[i][k] == p->at[j][k]; k++) {
            }
            if (k == p->dim && i != j) {
                return 0;
            }
            rank[i] += k < p->dim && p->at[j][k] > p->at[i][k];
        }
    }
    return 1;
}

static void swap_points(points *p, int i, int j)
{
    double q[4];
    memcpy(q, p->at[i], sizeof q);
    memcpy(p->at[i], p->at[j], sizeof q);
    memcpy(p->at[j], q, sizeof q);
}

/* The perturbed sign of a power determinant of 0, from the definition: it is a polynomial in the infinitesimals, with
   one linear term a point, whose coefficient is the determinant with that point's lift 1 and all others 0. */
static int true_perturbed_sign(const points *p, const int *rank)
{
    points rest;
    int dim = p->dim, i, j, level, sign = 0;
    rest.dim = dim;
    for (level = 0; level < dim + 2 && sign == 0; level++) {
        for (i = 0; rank[i] != level; i++) {
        }
        for (j = 0; j < dim + 2; j++) {                    /* that determinant is an orientation of the others */
            if (j != i) {
                memcpy(rest.at[j - (j > i)], p->at[j], sizeof p->at[j]);
            }
        }
        sign = true_sign(&rest, 0, NULL) * ((dim + i) % 2 == 0 ? 1 : -1);
    }
    return sign;
}

/* --- the predicates, by stage --- */

enum { FILTER, INTEGERS, GRID, PAIRS, LANES, EXACT, KERNEL, PUBLIC, STAGES, VECTORS = STAGES, HULL };

static const char *const stage_name[] = { "filter", "integers", "grid", "pairs", "lanes", "exact", "kernel", "public",
                                          "vectors", "the hull" };

static int have_vectors(void)
{
#ifdef PBW__SIMD
    return pbw__simd_works();
#else
    return 0;
#endif
}

#ifdef PBW__SIMD
/* Pairs in four lanes, without weights.  The far vertices are the corners themselves: then all lanes have the
   determinant of the simplex, but negative, as if it was seen from a neighbour. */
static int lanes_sign(const points *p, int power)
{
    static const pbw_index corner[4] = { 1, 2, 3, 4 };
    pbw_index turn[3][4] = { { 3, 1, 2, 3 }, { 2, 3, 1, 2 }, { 1, 2, 3, 1 } };
    double record[5 * 4] = { 0 };
    pbw__kernel kernel;
    unsigned certain, inside;
    int i, k, weighted = 0, dim = p->dim;
    memset(&kernel, 0, sizeof kernel);
    kernel.record = record;
    kernel.width = (size_t)dim + 1;
    for (i = 0; i < dim + 2; i++) {
        weighted |= p->at[i][dim] != 0;
        for (k = 0; k < dim && i <= dim; k++) {
            record[(i + 1) * (dim + 1) + k] = p->at[i][k];
        }
    }
    if (!have_vectors() || !power || weighted) {
        return PBW__OPEN;
    }
    certain = dim == 3 ? pbw__power4_pairs(&kernel, corner, corner, p->at[4], &inside)
                       : pbw__circle4_pairs(&kernel, turn, p->at[3], &inside);
    inside &= certain;
    CHECK(inside == 0 || inside == certain);
    return certain == 0 ? PBW__OPEN : (inside == 0) == (dim == 3) ? 1 : -1;
}
#else
static int lanes_sign(const points *p, int power)
{
    (void)p;
    (void)power;
    return PBW__OPEN;
}
#endif

static int public_sign(const points *p, int power)
{
    static const double zero = 0;
    const double (*q)[4] = p->at;
    double w[5];
    int i;
    for (i = 0; i < p->dim + 2; i++) {
        w[i] = q[i][p->dim];
    }
    if (!power) {
        return p->dim == 2 ? pbw_orient2(q[0], q[1], q[2]) : pbw_orient3(q[0], q[1], q[2], q[3]);
    }
    for (i = 0; i < p->dim + 2 && memcmp(&w[i], &zero, sizeof zero) == 0; i++) {
    }
    if (i == p->dim + 2) {                                 /* not w[i] == 0: that holds for flushed denormals */
        return p->dim == 2 ? pbw_incircle(q[0], q[1], q[2], q[3]) : pbw_insphere(q[0], q[1], q[2], q[3], q[4]);
    }
    return p->dim == 2 ? pbw_power2(q[0], q[1], q[2], q[3], w) : pbw_power3(q[0], q[1], q[2], q[3], q[4], w);
}

/* --- edges in the plane, as an insertion tests them --- */

/* Four at once: the lanes hold the same determinant, of three points by turns.  Returns the sign, if some lane knows
   it, and 2 lanes that differ make 3; also the first lane's value and height.
   hull: by the bound for thin triangles. */
#ifdef PBW__SIMD
PBW__SIMD
#endif
static int vector_sign(const points *p, int hull, double *value, double *height)
{
    int sign = PBW__OPEN;
    *value = *height = 0;
#ifdef PBW__SIMD
    static const pbw_index lanes[3][4] = {                 /* far vertex, start, end */
        { 0, 1, 2, 0 }, { 2, 0, 1, 2 }, { 1, 2, 0, 1 }
    };
    double records[3 * 3], det[4], h[4];
    pbw__triangles triangles;
    pbw__rows4 rows[3];
    pbw__point4 origin;
    pbw__d4 vector, heights;
    unsigned certain, inside, k;
    int weighted = 0;
    for (k = 0; k < 3; k++) {
        memcpy(records + 3 * k, p->at[k], 3 * sizeof(double));
        weighted |= p->at[k][2] != p->at[3][2];
    }
    origin = pbw__point4_of(p->at[3], 2, weighted, 3);
    for (k = 0; k < 3; k++) {
        rows[k] = pbw__rows4_of(records, lanes[k], 0, &origin);
    }
    triangles.o = rows[0];
    triangles.s = rows[1];
    triangles.e = rows[2];
    inside = hull ? pbw__test2_simd(&triangles, 1, &certain) : pbw__test2_simd(&triangles, 0, &certain);
    vector = pbw__circle4(&triangles, &heights);
    memcpy(det, &vector, sizeof det);
    memcpy(h, &heights, sizeof h);
    *value = det[0];
    *height = h[0];
    for (k = 0; k < 4; k++) {
        if (certain >> k & 1) {
            int lane = (inside >> k & 1) != 0 ? 1 : -1;
            sign = sign == PBW__OPEN || sign == lane ? lane : 3;
        }
    }
#else
    (void)p;
    (void)hull;
#endif
    return sign;
}

/* At the hull. */
static int hull_sign(const points *p, int power)
{
#ifdef PBW__SIMD
    double value, error;
    if (power) {
        return vector_sign(p, 1, &value, &error);
    }
    value = pbw__right_of(p->at[0], p->at[1], p->at[2], &error);
    return value > error ? 1 : value < -error ? -1 : PBW__OPEN;
#else
    (void)p;
    (void)power;
    return PBW__OPEN;
#endif
}

static void scan_grid(const double *records, size_t count, int dim, pbw__grid *grid)
{
    pbw__grid_share share;
    pbw__grid_share_reset(&share);
    pbw__grid_add(&share, records, count, dim, dim + 1);
    pbw__grid_close(grid, &share, 1, dim);
}

static void find_grid(const points *p, pbw__grid *grid)
{
    double records[5 * 4];
    int i, dim = p->dim == 2 ? 2 : 3;
    for (i = 0; i < dim + 2; i++) {
        memcpy(records + i * (dim + 1), p->at[i], (size_t)(dim + 1) * sizeof *records);
    }
    scan_grid(records, (size_t)dim + 2, dim, grid);
}

/* orientation: filled by integer stages, and by the exact one, if power. */
static int stage_sign(const points *p, int power, int stage, const pbw__grid *grid, int *orientation)
{
    const double (*q)[4] = p->at, *row[4] = { q[0], q[1], q[2], q[3] };
    int dim = p->dim, count = dim + power;
    double value, height;
    pbw__digit pool[PBW__POOL];
    switch (stage) {
    case FILTER:
        if (power) {
            return dim == 2 ? pbw__filter_power2(q[0], q[1], q[2], q[3])
                            : pbw__filter_power3(q[0], q[1], q[2], q[3], q[4]);
        }
        return dim == 2 ? pbw__filter_orient2(q[0], q[1], q[2]) : pbw__filter_orient3(q[0], q[1], q[2], q[3]);
    case INTEGERS: return pbw__integers(dim, count, row, q[count], NULL, orientation);
    case GRID:
        return grid->inverse_unit == 0 ? PBW__OPEN : pbw__integers(dim, count, row, q[count], grid, orientation);
    case PAIRS: return pbw__pairs(dim, count, row, q[count]);
    case LANES: return lanes_sign(p, power);
    case EXACT: return pbw__exact_determinant_in(pool, dim, count, row, q[count], orientation);
    case KERNEL:
        return power ? pbw__power(dim, row, q[dim + 1], grid) : pbw__orient(dim, row, grid);
    case VECTORS: return vector_sign(p, 0, &value, &height);
    case HULL: return hull_sign(p, power);
    default: return public_sign(p, power);
    }
}

static int conflict(const points *p, const pbw__grid *grid)
{
    const double *const x[4] = { p->at[0], p->at[1], p->at[2], p->at[3] };
    return pbw__conflict(p->dim, x, p->at[p->dim + 1], grid);
}

typedef struct tally {
    long calls, zeros, decided[STAGES];
} tally;

static void print_points(const points *p)
{
    int i;
    for (i = 0; i < p->dim + 2; i++) {
        test_say("%a %a %a %a", p->at[i][0], p->at[i][1], p->at[i][2], p->dim == 3 ? p->at[i][3] : 0.0);
    }
}

static void check_stages(points *p, int power, tally *t)
{
    pbw__grid grid;
    int dim = p->dim, truth = true_sign(p, power, NULL), true_orientation[4], stage, side, i, j, rank[5];
    find_grid(p, &grid);
    for (i = 0; i <= dim && power && truth == 0; i++) {
        points other = *p;
        swap_points(&other, i, dim + 1);
        true_orientation[i] = true_sign(&other, 0, NULL);
    }
    t->calls++;
    t->zeros += truth == 0;
    for (stage = 0; stage < STAGES; stage++) {
        int orientation[4], sign = stage_sign(p, power, stage, &grid, orientation);
        t->decided[stage] += sign != PBW__OPEN;
        if (sign == PBW__OPEN && stage < EXACT) {
            continue;
        }
        if (!CHECK(sign == truth)) {
            test_say("%s says %d, truth %d", stage_name[stage], sign, truth);
            print_points(p);
        }
        for (i = 0; i <= dim && power && truth == 0 && (stage == INTEGERS || stage == GRID || stage == EXACT); i++) {
            CHECK(orientation[i] == true_orientation[i]);
        }
    }
    if (power && (truth == 0 || below(4) == 0) && (side = true_sign(p, 0, NULL)) != 0 && find_ranks(p, rank)) {
        if (side < 0) {
            swap_points(p, 0, 1);
            find_ranks(p, rank);
            truth = -truth;
        }
        CHECK(conflict(p, &grid) == ((truth != 0 ? truth : true_perturbed_sign(p, rank)) > 0));
        CHECK(conflict(p, NULL) == conflict(p, &grid));
    }
    i = below(dim + 1);                                    /* antisymmetry: two points of the simplex change places */
    j = (i + 1 + below(dim)) % (dim + 1);
    swap_points(p, i, j);
    CHECK(stage_sign(p, power, KERNEL, &grid, NULL) == -truth && public_sign(p, power) == -truth);
}

/* --- tests --- */

static void test_conventions(void)
{
    double a[3] = { 0, 0, 0 }, b[3] = { 1, 0, 0 }, c[3] = { 0, 1, 0 }, d[3] = { 0, 0, 1 };
    double in[3] = { 0.25, 0.25, 0.25 }, on[3] = { 1, 1, 0 }, out[3] = { 1.1, 1, 0 }, w[5] = { 0, 0, 0, 0, 0 };
    if (!test_begin("signs mean what the header says")) {
        return;
    }
    CHECK(pbw_orient2(a, b, c) == 1 && pbw_orient2(a, c, b) == -1 && pbw_orient2(a, b, b) == 0);
    CHECK(pbw_orient3(a, b, c, d) == 1 && pbw_orient3(b, a, c, d) == -1 && pbw_orient3(a, b, c, on) == 0);
    CHECK(pbw_incircle(a, b, c, in) == 1 && pbw_incircle(a, b, c, on) == 0 && pbw_incircle(a, b, c, out) == -1);
    CHECK(pbw_incircle(b, a, c, in) == -1);
    CHECK(pbw_insphere(a, b, c, d, in) == 1 && pbw_insphere(a, b, c, d, on) == 0);
    CHECK(pbw_insphere(a, b, c, d, out) == -1 && pbw_insphere(b, a, c, d, in) == -1);
    w[3] = 1e-300;                                         /* no say in the plane of a, b, c and p */
    CHECK(pbw_power3(a, b, c, d, on, w) == 0);
    w[3] = 0;
    w[4] = 5e-324;                                         /* a larger weight of p wins more, one of a corner less */
    CHECK(pbw_power3(a, b, c, d, on, w) == 1 && pbw_power2(a, b, c, on, w + 1) == 1);
    w[0] = 1e-323;
    CHECK(pbw_power3(a, b, c, d, on, w) == 1);             /* opposite to p: its coefficient is negative */
    w[0] = 0;
    w[1] = 1e-323;
    CHECK(pbw_power3(a, b, c, d, on, w) == -1);
    w[1] = 0;
    w[4] = -5e-324;
    CHECK(pbw_power3(a, b, c, d, on, w) == -1 && pbw_power2(a, b, c, on, w + 1) == -1);
    test_end();
}

static void test_families(long calls)
{
    static tally tallies[2][2][FAMILIES];
    int dim, power, family, stage;
    for (family = 0; family < FAMILIES; family++) {        /* numbers of 10,000 bits take the oracle milliseconds */
        long n = family >= MIXED ? calls / 1600 + 1 : calls / MIXED + 1, i;
        for (dim = 2; dim <= 3; dim++) {
            for (power = 0; power < 2; power++) {
                tally *t = &tallies[dim - 2][power][family];
                if (test_begin("%s%d, %s", power ? "power" : "orient", dim, family_name[family])) {
                    for (i = 0; i < n; i++) {
                        points p;
                        fill(&p, dim, family);
                        check_stages(&p, power, t);
                    }
                    if (test_verbose) {
                        double percent = 100.0 / (double)t->calls;
                        test_say("%ld calls, %.1f%% zero; decided by", t->calls, percent * (double)t->zeros);
                        for (stage = 0; stage < EXACT; stage++) {
                            test_say("%8s %5.1f%%", stage_name[stage], percent * (double)t->decided[stage]);
                        }
                    }
                    test_end();
                }
            }
        }
    }
}

/* Each stage must earn its place, or the tests above would pass with a ladder that always falls through. */
static void test_reach(void)
{
    static const struct { const char *what; int family, dim, power, weights, stage; double least; } cases[] = {
        { "filter decides uniform points", UNIFORM, 3, 1, 0, FILTER, 0.99 },
        { "filter decides uniform points", UNIFORM, 2, 0, 0, FILTER, 0.99 },
        { "integers decide lattices", LATTICE, 3, 1, 1, INTEGERS, 0.99 },
        { "integers decide lattices", LATTICE, 2, 1, 1, INTEGERS, 0.99 },
        { "grid decides lattices", LATTICE, 3, 1, 1, GRID, 0.99 },
        { "grid decides lattices", LATTICE, 2, 0, 0, GRID, 0.99 },
        { "grid decides lattices of tenths", TENTHS, 3, 1, 0, GRID, PBW__DIGIT_BITS == 58 ? 0.99 : 0.0 },
        { "integers decide points of a cap", CAP, 3, 1, 0, INTEGERS, PBW__DIGIT_BITS == 58 ? 0.5 : 0.0 },
        { "integers decide faint lattices", FAINT_LATTICE, 2, 1, 0, INTEGERS, PBW__DIGIT_BITS == 58 ? 0.97 : 0.0 },
        { "integers decide faint lattices", FAINT_LATTICE, 3, 1, 0, INTEGERS, PBW__DIGIT_BITS == 58 ? 0.97 : 0.0 },
        { "integers decide lattices of two scales", SCALES, 2, 1, 0, INTEGERS, PBW__DIGIT_BITS == 58 ? 0.97 : 0.0 },
        { "pairs decide points of a cap", CAP, 3, 1, 0, PAIRS, 0.99 },
        { "pairs decide points of a sphere", SPHERE, 3, 1, 0, PAIRS, 0.99 },
        { "pairs decide points of a sphere", SPHERE, 2, 1, 0, PAIRS, 0.95 },
        { "pairs decide points of a plane", FLAT, 3, 0, 0, PAIRS, 0.5 },
        { "pairs decide exponents of +-30", MODERATE, 3, 1, 0, PAIRS, 0.99 },
        { "pairs decide denormals", DENORMAL, 3, 0, 0, PAIRS, 0.5 },
        { "pairs decide an axis of denormals", FAINT, 3, 1, 0, PAIRS, 0.9 },
        { "pairs decide an axis of denormals", FAINT, 2, 1, 0, PAIRS, 0.9 },
        { "pairs decide an axis of denormals", FAINT, 3, 0, 0, PAIRS, 0.9 },
        { "lanes decide points of a cap", CAP, 3, 1, 0, LANES, 0.99 },
        { "lanes decide points of a sphere", SPHERE, 3, 1, 0, LANES, 0.99 },
        { "lanes decide points of a circle", SPHERE, 2, 1, 0, LANES, 0.95 }
    };
    size_t i;
    int j, k, decided;
    for (i = 0; i < sizeof cases / sizeof *cases; i++) {
        if (test_begin("%s, %s%d", cases[i].what, cases[i].power ? "power" : "orient", cases[i].dim)) {
            if (cases[i].stage == LANES && !have_vectors()) {
                test_skip("no vectors");
                continue;
            }
            for (j = decided = 0; j < 1000; j++) {
                points p;
                pbw__grid grid;
                int orientation[4];
                p.dim = cases[i].dim;
                fill_places(&p, cases[i].family);
                for (k = 0; k < 5; k++) {                  /* not moved by ulps, weights of the lattice */
                    const int family = cases[i].family;
                    int axis;
                    for (axis = 0; axis < p.dim && (family == LATTICE || family == TENTHS || family >= FAINT_LATTICE);
                         axis++) {
                        p.at[k][axis] = coordinate(cases[i].family, axis);
                    }
                    p.at[k][p.dim] = cases[i].weights ? below(9) : 0;
                }
                find_grid(&p, &grid);
                decided += stage_sign(&p, cases[i].power, cases[i].stage, &grid, orientation) != PBW__OPEN;
            }
            if (!CHECK(decided >= 1000 * cases[i].least) || test_verbose) {
                test_say("%d of 1000", decided);
            }
            test_end();
        }
    }
}

static void set_flushing(unsigned bits)
{
#if defined(__SSE2__)
    _mm_setcsr((_mm_getcsr() & ~0x8040u) | bits);
#else
    (void)bits;
#endif
}

static void test_modes(long calls)
{
    static const int modes[4] = { FE_TONEAREST, FE_DOWNWARD, FE_UPWARD, FE_TOWARDZERO };
    static const char *const names[4] = { "to nearest", "down", "up", "to zero" };
    int (*volatile call)(const points *, int) = public_sign;   /* volatile: no call moves across a change of mode */
    int mode, flush;
    for (mode = 0; mode < 4; mode++) {
        for (flush = 0; flush < 2; flush++) {
            if (test_begin("public predicates, rounding %s%s", names[mode], flush ? ", flushing denormals" : "")) {
                long i;
#if !defined(__SSE2__)
                if (flush) {
                    test_skip("no SSE2");
                    continue;
                }
#endif
                for (i = 0; i < calls; i++) {
                    static points p;
                    int power = below(2), family = below(50) == 0 ? MIXED + below(2) : below(MIXED), truth, sign;
                    fill(&p, 2 + below(2), family);
                    if (below(8) == 0) {                   /* near where differences, squares or weights flush */
                        int j, k, down = below(2) == 0 ? 500 + below(40) : 950 + below(70);
                        for (j = 0; j < 5; j++) {
                            for (k = 0; k < 4; k++) {
                                p.at[j][k] = ldexp(p.at[j][k], k == p.dim ? -1060 : -down);
                            }
                        }
                    }
                    truth = true_sign(&p, power, NULL);
                    fesetround(modes[mode]);
                    set_flushing(flush ? 0x8040u : 0);
                    sign = call(&p, power);
                    set_flushing(0);
                    fesetround(FE_TONEAREST);
                    if (!CHECK(sign == truth)) {
                        test_say("power %d, family %s, says %d, truth %d", power, family_name[family], sign, truth);
                        print_points(&p);
                    }
                }
                test_end();
            }
        }
    }
}

/* Verdicts against infinitesimals that are true numbers: 2^-64 for the largest point, 2^-128 for the next and so on,
   where coefficients are below 2^12. */
static void test_raised(long calls)
{
    int dim, mixed;
    for (dim = 2; dim <= 3; dim++) {
        for (mixed = 0; mixed < 2; mixed++) {
            if (test_begin("verdicts of small heights, %dD%s", dim, mixed ? ", weights" : "")) {
                long i, ties = 0;
                for (i = 0; i < calls; i++) {
                    points p;
                    int k, side, rank[5];
                    p.dim = dim;
                    for (k = 0; k < dim + 2; k++) {
                        int axis;
                        for (axis = 0; axis < dim; axis++) {
                            p.at[k][axis] = below(4) - 1;
                        }
                        p.at[k][dim] = !mixed ? 0 : below(3) == 0 ? square(&p, k) : below(3);
                    }
                    side = true_sign(&p, 0, NULL);
                    if (side < 0) {
                        swap_points(&p, 0, 1);
                    }
                    if (side != 0 && find_ranks(&p, rank)) {
                        int sign = true_sign(&p, 1, NULL), raised = true_sign(&p, 1, rank);
                        ties += sign == 0;
                        CHECK(raised == (sign != 0 ? sign : true_perturbed_sign(&p, rank)));
                        CHECK(conflict(&p, NULL) == (raised > 0));
                    }
                }
                CHECK(ties >= calls / 200);
                test_end();
            }
        }
    }
}

/* dim+2 points have one circuit: whichever of them is asked about, the verdicts must tell of the same sign of it. */
static void test_circuits(long calls)
{
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("verdicts agree on all splits of %d points", dim + 2)) {
            long i;
            for (i = 0; i < calls; i++) {
                points p;
                int j, k, sign = 0, rank[5];
                p.dim = dim;
                for (k = 0; k < dim + 2; k++) {
                    for (j = 0; j < dim; j++) {
                        p.at[k][j] = below(3);
                    }
                    p.at[k][dim] = below(4) == 0 ? square(&p, k) : below(2);
                }
                if (!find_ranks(&p, rank)) {
                    continue;
                }
                for (j = 0; j < dim + 2; j++) {            /* point j as the query: odd unless it is so already */
                    points q = p;
                    int orientation, verdict;
                    swap_points(&q, j, dim + 1);
                    orientation = stage_sign(&q, 0, KERNEL, NULL, NULL);
                    if (orientation == 0) {
                        continue;
                    }
                    if (orientation < 0) {
                        swap_points(&q, 0, 1);
                    }
                    verdict = conflict(&q, NULL) ? 1 : -1;
                    verdict *= orientation * (j == dim + 1 ? 1 : -1);
                    CHECK(sign == 0 || sign == verdict);
                    sign = verdict;
                }
            }
            test_end();
        }
    }
}

/* The simplices without conflicts tile the hull: their volume is that for heights raised in the reverse order. */
static void test_tiling(long calls)
{
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("simplices without conflicts tile the hull, %dD", dim)) {
            long i;
            for (i = 0; i < calls; i++) {
                double at[7][4], volume[2] = { 0, 0 };
                int j, k, n = 7, way;
                unsigned set;
                for (j = 0; j < n; j++) {
                    for (k = 0; k < dim; k++) {
                        at[j][k] = below(3);
                    }
                    at[j][dim] = 0;
                    for (k = 0; k < j && memcmp(at[j], at[k], (size_t)dim * sizeof(double)) != 0; k++) {
                    }
                    j -= k < j;                            /* once more if the place is taken */
                }
                for (way = 0; way < 2; way++) {
                    for (set = 0; set < 1u << n; set++) {
                        points p;
                        double size;
                        int empty = 1, rank[5];
                        p.dim = dim;
                        for (j = k = 0; j < n && k <= dim + 1; j++) {
                            if (set >> j & 1) {
                                memcpy(p.at[k++], at[j], sizeof at[j]);
                            }
                        }
                        if (k != dim + 1) {
                            continue;
                        }
                        memset(p.at[dim + 1], 0, sizeof p.at[0]);
                        size = 0;
                        for (k = 0; k <= dim; k++) {       /* exact: small integers */
                            points q = p;
                            memset(q.at[dim + 1], 0, sizeof q.at[0]);
                            size += k % 2 == 0 ? cofactor(&q, k) : -cofactor(&q, k);
                        }
                        if (size == 0) {
                            continue;
                        }
                        if (stage_sign(&p, 0, KERNEL, NULL, NULL) < 0) {
                            swap_points(&p, 0, 1);
                        }
                        for (j = 0; j < n && empty; j++) {
                            if (set >> j & 1) {
                                continue;
                            }
                            memcpy(p.at[dim + 1], at[j], sizeof at[j]);
                            find_ranks(&p, rank);
                            for (k = 0; k < dim + 2; k++) {
                                rank[k] = dim + 1 - rank[k];
                            }
                            empty = !(way == 0 ? conflict(&p, NULL) : true_sign(&p, 1, rank) > 0);
                        }
                        volume[way] += empty ? fabs(size) : 0;
                    }
                }
                CHECK(volume[0] == volume[1]);
            }
            test_end();
        }
    }
}

/* The true value, about, and the bound below which the stage must not answer. */
static double true_value(const points *p, int power, int stage, double *bound)
{
    static const double factor[2][2][2] = {
        { { PBW__FILTER_ORIENT2_ERROR, PBW__PAIRS_ORIENT2_ERROR },
          { PBW__FILTER_POWER2_ERROR, PBW__PAIRS_POWER2_ERROR } },
        { { PBW__FILTER_ORIENT3_ERROR, PBW__PAIRS_ORIENT3_ERROR },
          { PBW__FILTER_POWER3_ERROR, PBW__PAIRS_POWER3_ERROR } }
    };
    int dim = p->dim, count = dim + power, i, k;
    double value = 0, lift = 0;
    oracle_big truth;
    int unit = true_determinant(p, power, NULL, &truth) * (power ? dim + 2 : dim);
    *bound = stage == LANES ? dim == 3 ? PBW__SPHERE_PAIRS_ERROR : PBW__CIRCLE_PAIRS_ERROR
           : factor[dim - 2][power][stage == PAIRS] * (stage == PAIRS ? 0x1p-106 : 0x1p-52);
    for (k = 0; k < dim && stage != LANES; k++) {
        double largest = 0;
        for (i = 0; i < count; i++) {
            largest = fmax(largest, fabs(p->at[i][k] - p->at[count][k]));
        }
        *bound *= largest;
    }
    for (i = 0; i < count; i++) {
        double norm = !power && stage != HULL ? 0 : fabs(p->at[i][dim] - p->at[count][dim]);
        for (k = 0; k < dim; k++) {
            norm += (p->at[i][k] - p->at[count][k]) * (p->at[i][k] - p->at[count][k]);
        }
        lift = fmax(lift, norm);
    }
    *bound *= stage == LANES ? lift * lift * (dim == 3 ? sqrt(lift) : 1) : power ? lift : 1;
    if (stage == VECTORS) {
        *bound = PBW__CIRCLE_ERROR * lift * lift;
    }
    if (stage == HULL) {
        *bound = power ? 0 : PBW__ORIENT2_ERROR * lift;
    }
    for (i = 0; i < count && power && stage == HULL; i++) {
        const double *a = p->at[(i + 1) % count], *b = p->at[(i + 2) % count], *c = p->at[i], *o = p->at[count];
        *bound += PBW__THIN_ERROR * ((c[0] - o[0]) * (c[0] - o[0]) + (c[1] - o[1]) * (c[1] - o[1]))
                * (fabs((a[0] - o[0]) * (b[1] - o[1])) + fabs((a[1] - o[1]) * (b[0] - o[0])));
    }
    for (i = truth.length - 1; i >= 0 && i >= truth.length - 3; i--) {
        value += ldexp(truth.limb[i], 32 * i + unit);
    }
    return truth.sign * value;
}

/* Looks for a wrong answer where a stage is only just certain: changes one number after another so that the value
   drops to about its bound, and keeps what brings it nearer.  Half of the starts have tiny coordinates in the origin:
   without their fine ulps the bounds of pairs are out of reach. */
static void test_attack(long steps)
{
    static const int starts[6] = { UNIFORM, SPHERE, CAP, FLAT, CLUSTER, MODERATE };
    int dim, power, start;
    for (dim = 2; dim <= 3; dim++) {
        for (power = 0; power < 2; power++) {
            static const int stages[5] = { FILTER, PAIRS, LANES, VECTORS, HULL };
            int attacked;
            for (attacked = 0; attacked < 5; attacked++) {
                int stage = stages[attacked];
                double nearest = HUGE_VAL;
                long answers = 0;
                int columns = stage == LANES || stage == HULL ? dim : dim + power;
                if (((stage == LANES || stage == VECTORS) && !power) || (stage >= VECTORS && dim == 3)
                    || !test_begin("attack on %s, %s%d", stage_name[stage], power ? "power" : "orient", dim)) {
                    continue;
                }
                if (stage >= LANES && !have_vectors()) {
                    test_skip("no vectors");
                    continue;
                }
                for (start = 0; start < 6; start++) {
                    points p;
                    double best = HUGE_VAL, value = 0, bound = 0, aim = 1;
                    long step;
                    int k;
                    for (step = 0; step < steps; step++) {
                        points next = p;
                        double *x = &next.at[below(dim + 1 + power)][below(columns)], old = *x;
                        int answer;
                        if (step % 256 == 0) {             /* a new start */
                            fill(&next, dim, starts[start]);
                            for (k = 0; k < dim + 2 && columns == dim; k++) {
                                next.at[k][dim] = 0;
                            }
                            for (k = 0; k < dim + power && step % 512 == 0; k++) {
                                next.at[dim + power][k] *= 0x1p-60;
                            }
                            best = HUGE_VAL;
                        } else {
                            double move = 0x1p-26, slope;
                            *x = old + move;
                            slope = (true_value(&next, power, stage, &bound) - value) / (*x - old);
                            *x = ulps(old + (bound * aim * (4 * unit_random() - 2) - value) / slope, below(3) - 1);
                            if (!(*x - *x == 0)) {
                                continue;
                            }
                        }
                        value = true_value(&next, power, stage, &bound);
                        answer = stage_sign(&next, power, stage, NULL, NULL);
                        if (answer != PBW__OPEN) {
                            answers++;
                            if (!CHECK(answer * value > 0)) {
                                print_points(&next);
                            }
                            aim = fmin(aim, fabs(value) / bound);
                        }
                        nearest = fmin(nearest, aim);
                        if (step % 256 == 0 || fabs(value) / bound <= fmax(best, 4)) {
                            best = fabs(value) / bound;
                            p = next;
                        } else {
                            value = true_value(&p, power, stage, &bound);
                        }
                    }
                }
                CHECK(answers > steps);                    /* or the attack was none */
                CHECK(nearest > 0.5);                      /* errors have never been half of the bound */
                if (test_verbose) {
                    test_say("%ld certain answers, down to %.4f of the bound", answers, nearest);
                }
                test_end();
            }
        }
    }
}

/* --- four lanes at once --- */

#ifdef PBW__SIMD
/* A simplex, the far vertices across its facets and a point, as the kernel has them: record 0 is the ghost. */
typedef struct neighbourhood {
    double record[9][4], p[4];
    pbw_index corner[4], far[4];
} neighbourhood;

/* Ghosts: 0 none, 1 far vertices, 2 corner 3. */
static void fill_neighbourhood(neighbourhood *n, int family, int ghosts)
{
    static const int sides[3] = { 1, 30, 465 };            /* 3 * 465^2 is just below PBW__EXACT_HEIGHT3 */
    int box = below(2), steps = below(2) == 0 ? 1 : 155, side[3], i, k;
    points p;
    for (k = 0; k < 3; k++) {
        side[k] = sides[below(3)];
    }
    p.dim = 3;
    memset(n, 0, sizeof *n);
    n->record[0][0] = HUGE_VAL;
    fill_places(&p, family);                               /* those that share a sphere or plane come in fives */
    for (i = 0; i < 9; i++) {
        double *q = i < 8 ? n->record[i + 1] : n->p;
        int copy = below(5);
        for (k = 0; k < 3; k++) {
            q[k] = i < 4 ? p.at[i][k] : i == 8 ? p.at[4][k] : p.at[copy][k];
            if (family == LATTICE) {                       /* or corners of a box */
                q[k] = box ? side[k] * below(2) : steps * below(4);
            } else if (family == COSPHERICAL) {
                q[k] = floor(q[k] + 0.5);                  /* some have been moved by an ulp */
            } else if (i >= 4 && i < 8) {
                q[k] = ulps(q[k], below(5) - 2);
            }
        }
    }
    for (i = 0; i < 4; i++) {
        n->corner[i] = (pbw_index)(i + 1);
        n->far[i] = ghosts == 1 && below(2) == 0 ? PBW__GHOST : (pbw_index)(i + 5);
    }
    n->corner[3] = ghosts == 2 ? PBW__GHOST : n->corner[3];
}

/* The simplex with corner k replaced by its far vertex, and the point; the ghost, if there is one, becomes the point
   itself: what is left is the orientation of the others, of sign *flip. */
static int lane_truth(const neighbourhood *n, int k, points *p)
{
    int i, ghost = -1;
    p->dim = 3;
    for (i = 0; i < 4; i++) {
        pbw_index v = i == k ? n->far[i] : n->corner[i];
        memcpy(p->at[i], v == PBW__GHOST ? n->p : n->record[v], sizeof p->at[i]);
        ghost = v == PBW__GHOST ? i : ghost;
    }
    memcpy(p->at[4], n->p, sizeof n->p);
    return ghost < 0 ? -true_sign(p, 1, NULL) : -true_sign(p, 0, NULL);
}

static void test_lanes(long calls)
{
    static const int families[8] = { UNIFORM, LATTICE, COSPHERICAL, SPHERE, CAP, FLAT, CLUSTER, MODERATE };
    int f, ghosts, k;
    for (f = 0; f < 8; f++) {
        for (ghosts = 0; ghosts < 3; ghosts++) {
            long i, answers = 0, ties = 0;
            int exact = families[f] == LATTICE || families[f] == COSPHERICAL;
            if (!test_begin("four lanes, %s%s", family_name[families[f]],
                            ghosts == 0 ? "" : ghosts == 1 ? ", ghosts beyond" : ", a ghost")) {
                continue;
            }
            if (!have_vectors()) {
                test_skip("no vectors");
                continue;
            }
            for (i = 0; i < calls; i++) {
                neighbourhood n;
                pbw__kernel kernel;
                unsigned certain, inside, tied;
                fill_neighbourhood(&n, families[f], ghosts);
                memset(&kernel, 0, sizeof kernel);
                kernel.record = n.record[0];
                kernel.width = sizeof n.record[0] / sizeof(double);
                certain = pbw__power4_pairs(&kernel, n.corner, n.far, n.p, &inside);
                tied = exact ? pbw__ties4(&kernel, n.corner, n.far, n.p) : 0;
                for (k = 0; k < 4; k++) {
                    points p;
                    int rank[5], truth = lane_truth(&n, k, &p);
                    if (certain >> k & 1) {
                        answers++;
                        if (!CHECK(truth == ((inside >> k & 1) != 0 ? 1 : -1))) {
                            print_points(&p);
                        }
                    } else if (exact && truth == 0 && n.far[k] != PBW__GHOST && (ghosts < 2 || k == 3)
                               && true_sign(&p, 0, NULL) < 0 && find_ranks(&p, rank)) {
                        swap_points(&p, 0, 1);
                        find_ranks(&p, rank);
                        ties++;
                        CHECK((int)(tied >> k & 1) == (true_perturbed_sign(&p, rank) > 0));
                    }
                }
            }
            CHECK(exact ? ties > calls / 100 : answers > calls);         /* of the 4 a call */
            if (test_verbose) {
                test_say("%.2f certain, %.2f ties a call", (double)answers / (double)calls,
                         (double)ties / (double)calls);
            }
            test_end();
        }
    }
}
#endif

/* What vectors are sure of is true; where nothing is rounded, so is the determinant itself. */
static void test_vectors(long calls)
{
    int power, family, k;
    for (power = 0; power < 2; power++) {
        for (family = 0; family <= FAMILIES; family++) {
            long n = family >= MIXED && family < FAMILIES ? calls / 1600 + 1 : calls / MIXED + 1, i, exact = 0;
            if (!test_begin("vectors, %s2, %s", power ? "circle" : "orient",
                            family < FAMILIES ? family_name[family] : "small integers")) {
                continue;
            }
            if (!have_vectors()) {
                test_skip("no vectors");
                continue;
            }
            for (i = 0; i < n; i++) {
                points p;
                double value = 0, height = 0, bound;
                int sign, truth, flat = below(2), low = below(5000), high = 4 + below(below(2) ? 6100 : 20000);
                fill(&p, 2, family < FAMILIES ? family : UNIFORM);
                for (k = 0; k < 4; k++) {
                    if (family == FAMILIES) {
                        p.at[k][0] = low + below(high);
                        p.at[k][1] = low - below(high);
                        p.at[k][2] = below(high) * below(high);
                    }
                    p.at[k][2] *= !flat;
                }
                truth = true_sign(&p, power, NULL);
                sign = hull_sign(&p, power);
                if (!CHECK(sign == PBW__OPEN || sign == truth)) {
                    print_points(&p);
                }
                sign = power ? vector_sign(&p, 0, &value, &height) : PBW__OPEN;
                if (!CHECK(sign == PBW__OPEN || sign == truth)) {
                    print_points(&p);
                }
                if (power && family == FAMILIES && height < PBW__EXACT_HEIGHT2) {
                    CHECK(value == true_value(&p, power, FILTER, &bound));
                    exact++;
                }
            }
            CHECK(exact > n / 8 || family < FAMILIES || !power);
            test_end();
        }
    }
}

/* --- grids --- */

static void test_grids(long calls)
{
    double records[40 * 4];
    pbw__grid grid;
    int dim, j, k;
    long i;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("grids found in %d dimensions", dim)) {
            for (i = 0; i < calls; i++) {
                int unit = below(400) - 200, bits = below(40), weighted = below(2), n = 2 + below(38), q;
                double offset = ldexp(below(3) == 0 ? 4503599627370496.0 : below(1000), unit), span = 0, heaviest = 0;
                double low[4], high[4];
                for (j = 0; j < n; j++) {
                    for (k = 0; k <= dim; k++) {
                        double r = (double)(random_bits() >> (63 - bits)), *x = &records[j * (dim + 1) + k];
                        if (j == 0 && k == 0 && fmod(r, 2) == 0) {
                            r += 1;
                        }
                        *x = k < dim ? ldexp(r, unit) + offset : weighted ? ldexp(below(1000000), 2 * unit) : 0;
                        low[k] = j == 0 ? *x : fmin(low[k], *x);
                        high[k] = j == 0 ? *x : fmax(high[k], *x);
                    }
                }
                for (k = 0; k < dim; k++) {
                    span = fmax(span, high[k] - low[k]);
                }
                heaviest = high[dim] - low[dim];
                scan_grid(records, (size_t)n, dim, &grid);
                CHECK(grid.inverse_unit != 0 && grid.inverse_unit == ldexp(1, -ilogb(1 / grid.inverse_unit)));
                CHECK(span * grid.inverse_unit < ldexp(1, grid.bits));
                CHECK(heaviest * grid.inverse_unit * grid.inverse_unit < ldexp(1, 2 * grid.bits));
                CHECK(grid.bits == 0 || span * grid.inverse_unit >= ldexp(1, grid.bits - 1)
                      || heaviest * grid.inverse_unit * grid.inverse_unit >= ldexp(1, 2 * grid.bits - 2));
                for (q = j = 0; j < n * (dim + 1); j++) {
                    double units = records[j] * grid.inverse_unit;
                    units *= j % (dim + 1) == dim ? grid.inverse_unit : 1;
                    CHECK(units == rint(units));
                    q |= j % (dim + 1) == dim ? fmod(units, 4) != 0 : fmod(units, 2) != 0;
                }
                CHECK(q);                                  /* no coarser grid would do */
            }
            test_end();
        }
    }
    if (test_begin("no grids where there are none")) {
        for (i = 0; i < 1000; i++) {
            static const double odd[4] = { DBL_MAX, 5e-324, 1e200, 1e-200 };
            for (j = 0; j < 160; j++) {
                records[j] = unit_random() + 0x1p-53;      /* an odd multiple in one of two */
            }
            if (i % 2 == 0) {
                records[below(160)] = odd[below(4)] * (below(2) == 0 ? 1 : -1);
            } else {
                records[below(40) * 4] = (0.5 + unit_random()) * 0x1p-30;
            }
            scan_grid(records, 40, 3, &grid);
            CHECK(grid.inverse_unit == 0 && grid.bits == 0);
        }
        for (j = 0; j < 8; j++) {                          /* 2^53 units are too many */
            records[j] = j == 0 ? 4503599627370497.0 : j == 4 ? -4503599627370495.0 : 0;
        }
        scan_grid(records, 2, 3, &grid);
        CHECK(grid.inverse_unit == 0);
        records[0] -= 1;
        scan_grid(records, 2, 3, &grid);
        CHECK(grid.inverse_unit == 1 && grid.bits == 53);
        for (j = 0; j < 160; j++) {
            records[j] = j % 2 == 0 ? 0.0 : -0.0;
        }
        scan_grid(records, 40, 3, &grid);
        CHECK(grid.inverse_unit == 0);
        scan_grid(records, 0, 3, &grid);
        CHECK(grid.inverse_unit == 0);
        test_end();
    }
}

/* --- times --- */

static void print_times(void)
{
    static const int families[6] = { UNIFORM, LATTICE, TENTHS, SPHERE, CAP, FLOATS };
    static points p[1024];
    int (*volatile ask)(const points *, int, int, const pbw__grid *, int *) = stage_sign;   /* volatile: is called */
    int dim, power, f, stage, i;
    for (f = 0; f < 6; f++) {
        for (dim = 3; dim >= 2; dim--) {
            for (power = 1; power >= 0; power--) {
                pbw__grid grid = { 1, 2 }, none = { 0, 0 };
                for (i = 0; i < 1024; i++) {
                    int k;
                    do {
                        p[i].dim = dim;
                        fill_places(&p[i], families[f]);
                        for (k = 0; k < 5; k++) {
                            int axis;
                            for (axis = 0; axis < dim && (families[f] == LATTICE || families[f] == TENTHS); axis++) {
                                p[i].at[k][axis] = coordinate(families[f], axis);
                            }
                            p[i].at[k][dim] = 0;
                        }
                    } while (stage_sign(&p[i], 0, EXACT, NULL, NULL) <= 0);
                }
                printf("%-20s %s%d: ns", family_name[families[f]], power ? "power" : "orient", dim);
                for (stage = FILTER; stage < PUBLIC; stage++) {
                    double least = HUGE_VAL;
                    int repeat;
                    if (stage == GRID && families[f] != LATTICE) {
                        continue;
                    }
                    for (repeat = 0; repeat < 9; repeat++) {
                        int orientation[4];
                        clock_t start = clock();
                        for (i = 0; i < 32 * 1024; i++) {
                            ask(&p[i % 1024], power, stage, stage == GRID ? &grid : &none, orientation);
                        }
                        least = fmin(least, (double)(clock() - start) / CLOCKS_PER_SEC / (32 * 1024));
                    }
                    printf("  %s %.0f", stage_name[stage], least * 1e9);
                }
                printf("\n");
            }
        }
    }
}

int main(int argc, char **argv)
{
    long calls = CALLS;
    int i, kept = 1, times = 0;
    for (i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--long") == 0) {
            calls = 1000000;
        } else if (strcmp(argv[i], "--time") == 0) {
            times = 1;
        } else {
            argv[kept++] = argv[i];
        }
    }
    test_start(kept, argv, calls);
    state = test_seed;
    if (times) {
        print_times();
        return 0;
    }
    test_conventions();
    test_families(test_count);
    test_reach();
    test_attack(test_count / 100 + 512);
    test_vectors(test_count);
    test_modes(test_count / 40);
    test_raised(test_count / 40);
    test_circuits(test_count / 40);
    test_tiling(test_count / 2000);
#ifdef PBW__SIMD
    test_lanes(test_count / 40 + 512);
#endif
    test_grids(test_count / 20);
    return test_finish();
}
