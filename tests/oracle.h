/* oracle.h: the triangulation of a few points by brute force in exact integer arithmetic, straight from the
   definition and sharing no method with pbw.h.

   Every set of dim+2 points has one affine dependence, sum c_i (1, p_i) = 0, with c_i = +- the determinant of the
   other dim+1.  With lifts h_i = |p_i|^2 - w_i, the number D / c_i, D = sum c_i h_i, is the height of lifted point i
   above the plane through the others.  A simplex is in the triangulation if its determinant is not 0 and no other
   point is below its plane.  Ties (D = 0): h_i is really h_i + e_i with infinitesimals e_1 << e_2 << ... in the
   lexicographic order of the points, so the sign of D is that of the last nonzero c_i.

   Numbers: int64_t for small integers, else integers of any length, in units of a power of two small enough. */
#ifndef ORACLE_H
#define ORACLE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#define ORACLE_POINTS 12                        /* at most so many places */
#define ORACLE_LIMBS 400                        /* 12800 bits: enough for the worst doubles, see oracle_unit */

typedef struct oracle {
    int dim, places, duplicates, simplices;
    int owner[ORACLE_POINTS];                   /* the point that stays at each place; places are in order */
    int place[64];                              /* of each point */
    unsigned vertices;                          /* the places that are vertices, as bits */
    signed char simplex[1 << ORACLE_POINTS];    /* by the set of places, as bits: 0, or 1 or -1, the orientation of
                                                   its places in order */
} oracle;

/* --- integers of any length, sign and magnitude --- */

typedef struct oracle_big {
    int sign, length;                           /* sign 0: zero */
    uint32_t limb[ORACLE_LIMBS];                /* the lowest first, the last nonzero */
} oracle_big;

static inline void oracle_set(oracle_big *a, const oracle_big *b)
{
    a->sign = b->sign;
    a->length = b->length;
    memcpy(a->limb, b->limb, (size_t)b->length * sizeof b->limb[0]);
}

static inline int oracle_compare_magnitudes(const oracle_big *a, const oracle_big *b)
{
    int i;
    if (a->length != b->length) {
        return a->length < b->length ? -1 : 1;
    }
    for (i = a->length - 1; i >= 0 && a->limb[i] == b->limb[i]; i--) {
    }
    return i < 0 ? 0 : a->limb[i] < b->limb[i] ? -1 : 1;
}

/* sum += sign * a */
static inline void oracle_add(oracle_big *sum, const oracle_big *a, int sign)
{
    int64_t carry = 0;
    int i, larger, length = sum->length > a->length ? sum->length : a->length;
    sign *= a->sign;
    if (sign == 0) {
        return;
    }
    if (sum->sign == 0) {
        sum->sign = sign;
        sum->length = 0;
    }
    larger = oracle_compare_magnitudes(sum, a);
    for (i = 0; i < length || carry != 0; i++) {
        int64_t x = i < sum->length ? sum->limb[i] : 0, y = i < a->length ? a->limb[i] : 0;
        carry += sum->sign == sign ? x + y : larger >= 0 ? x - y : y - x;
        sum->limb[i] = (uint32_t)carry;
        carry >>= 32;
    }
    sum->sign = sum->sign == sign || larger > 0 ? sum->sign : larger == 0 ? 0 : sign;
    for (sum->length = i; sum->length > 0 && sum->limb[sum->length - 1] == 0; sum->length--) {
    }
}

static inline void oracle_multiply(oracle_big *product, const oracle_big *a, const oracle_big *b)
{
    int i, j;
    product->sign = a->sign * b->sign;
    product->length = product->sign == 0 ? 0 : a->length + b->length;
    memset(product->limb, 0, (size_t)product->length * sizeof product->limb[0]);
    for (i = 0; i < a->length && product->sign != 0; i++) {
        uint64_t carry = 0;
        for (j = 0; j < b->length; j++, carry >>= 32) {
            carry += (uint64_t)a->limb[i] * b->limb[j] + product->limb[i + j];
            product->limb[i + j] = (uint32_t)carry;
        }
        product->limb[i + b->length] = (uint32_t)carry;
    }
    for (; product->length > 0 && product->limb[product->length - 1] == 0; product->length--) {
    }
}

/* x in units of 2^unit, of which it is a multiple. */
static inline void oracle_from_double(oracle_big *a, double x, int unit)
{
    int exponent, shift, i;
    uint64_t mantissa = (uint64_t)ldexp(fabs(frexp(x, &exponent)), 53);
    a->sign = x > 0 ? 1 : x < 0 ? -1 : 0;
    a->length = 0;
    if (x == 0) {
        return;
    }
    exponent -= 53;
    for (; mantissa % 2 == 0; mantissa /= 2) {
        exponent++;
    }
    shift = exponent - unit;
    a->length = shift / 32 + 3;
    memset(a->limb, 0, (size_t)a->length * sizeof a->limb[0]);
    for (i = 0; i < 64; i++) {
        a->limb[(shift + i) / 32] |= (uint32_t)(mantissa >> i & 1) << (shift + i) % 32;
    }
    for (; a->limb[a->length - 1] == 0; a->length--) {
    }
}

/* The exponent of the lowest bit of x, 0 counting as the highest. */
static inline int oracle_lowest(double x)
{
    int exponent;
    double mantissa = frexp(x, &exponent);
    if (x == 0) {
        return 1024;
    }
    for (; mantissa != (double)(int64_t)mantissa; mantissa *= 2) {
        exponent--;
    }
    return exponent;
}

/* The unit of the coordinates: its square is the unit of the lifts, so it must suit the weights too.  The lowest is
   2^-1074, thus coordinates have at most 2098 bits, lifts 4199, and determinants of lifts 10600. */
static inline int oracle_unit(int dim, int n, const double *points, const double *weights)
{
    int i, unit = 1024;
    for (i = 0; i < n * dim; i++) {
        int lowest = oracle_lowest(points[i]);
        unit = lowest < unit ? lowest : unit;
    }
    for (i = 0; i < n && weights != NULL; i++) {
        int lowest = oracle_lowest(weights[i]);
        unit = lowest < 2 * unit ? (int)floor(lowest / 2.0) : unit;
    }
    return unit;
}

/* The determinant of rows row..n-1 and a set of as many columns, expanded by the first of the rows. */
static inline void oracle_big_determinant(oracle_big *value, int n, oracle_big (*m)[3], int row, unsigned columns)
{
    static oracle_big minors[3], term;                /* static: too large for a small stack */
    int k, sign = 1;
    value->sign = value->length = 0;
    for (k = 0; k < 3; k++) {
        if (columns >> k & 1 && row == n - 1) {
            oracle_set(value, &m[row][k]);
        } else if (columns >> k & 1) {
            oracle_big_determinant(&minors[row], n, m, row + 1, columns & ~(1u << k));
            oracle_multiply(&term, &m[row][k], &minors[row]);
            oracle_add(value, &term, sign);
            sign = -sign;
        }
    }
}

static inline int64_t oracle_small_determinant(int n, int64_t (*m)[3])
{
    if (n == 2) {
        return m[0][0] * m[1][1] - m[0][1] * m[1][0];
    }
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* Integers this small keep determinants below 2^36, lifts below 2^24 and their sum of products below 2^63. */
static inline int oracle_is_small(int dim, int n, const double *points, const double *weights)
{
    int i;
    for (i = 0; i < n * dim; i++) {
        if (!(fabs(points[i]) <= 1024) || points[i] != (double)(int)points[i]) {
            return 0;
        }
    }
    for (i = 0; i < n && weights != NULL; i++) {
        if (!(fabs(weights[i]) <= 4194304) || weights[i] != (double)(int)weights[i]) {
            return 0;
        }
    }
    return 1;
}

/* --- the triangulation --- */

static inline int oracle_compare_places(int dim, const double *a, const double *b)
{
    int j;
    for (j = 0; j < dim; j++) {
        if (a[j] != b[j]) {
            return a[j] < b[j] ? -1 : 1;
        }
    }
    return 0;
}

/* Finds the places, and the point that stays at each: the largest weight, then the lowest index. */
static inline int oracle_find_places(oracle *o, int dim, int n, const double *points, const double *weights)
{
    int i, k;
    memset(o, 0, sizeof *o);
    o->dim = dim;
    for (i = 0; i < n; i++) {
        const double *p = points + i * dim;
        int order = 1;
        for (k = 0; k < o->places; k++) {
            order = oracle_compare_places(dim, p, points + o->owner[k] * dim);
            if (order <= 0) {
                break;
            }
        }
        if (k < o->places && order == 0) {
            o->duplicates++;
            if (weights != NULL && weights[i] > weights[o->owner[k]]) {
                o->owner[k] = i;
            }
        } else if (o->places == ORACLE_POINTS) {
            return 0;
        } else {
            memmove(o->owner + k + 1, o->owner + k, (size_t)(o->places - k) * sizeof o->owner[0]);
            o->owner[k] = i;
            o->places++;
        }
    }
    for (i = 0; i < n; i++) {
        for (k = 0; oracle_compare_places(dim, points + i * dim, points + o->owner[k] * dim) != 0; k++) {
        }
        o->place[i] = k;
    }
    return 1;
}

static inline unsigned oracle_next_subset(unsigned set)                      /* the next with as many bits */
{
    unsigned lowest = set & (0u - set), ripple = set + lowest;
    return ripple | (((ripple ^ set) >> 2) / lowest);
}

/* The sign of sum (-1)^i c_i h_i over a set of dim+2 places, perturbed; the signs of (-1)^i c_i. */
static inline int oracle_dependence(const oracle *o, unsigned set, int small, const int64_t *determinant,
                                    const int64_t *lift, const oracle_big *big_determinant,
                                    const oracle_big *big_lift, int signs[ORACLE_POINTS])
{
    static oracle_big big_sum, term;
    int64_t sum = 0;
    int k, flip = 1, last = 0, sign;
    big_sum.sign = big_sum.length = 0;
    for (k = 0; k < o->places; k++) {
        unsigned others = set & ~(1u << k);
        if (others == set) {
            continue;
        }
        if (small) {
            sum += flip * determinant[others] * lift[k];
            signs[k] = flip * ((determinant[others] > 0) - (determinant[others] < 0));
        } else {
            oracle_multiply(&term, &big_determinant[others], &big_lift[k]);
            oracle_add(&big_sum, &term, flip);
            signs[k] = flip * big_determinant[others].sign;
        }
        last = signs[k] != 0 ? signs[k] : last;
        flip = -flip;
    }
    sign = small ? (sum > 0) - (sum < 0) : big_sum.sign;
    return sign != 0 ? sign : last;
}

/* Triangulates n <= 64 points at no more than ORACLE_POINTS places (else returns 0); wide forces long integers. */
static inline int oracle_solve(oracle *o, int dim, int n, const double *points, const double *weights, int wide)
{
    static int64_t determinant[1 << ORACLE_POINTS], lift[ORACLE_POINTS];
    static oracle_big big_determinant[1 << ORACLE_POINTS], big_lift[ORACLE_POINTS], big_place[ORACLE_POINTS][3];
    static oracle_big big[3][3], square;
    int64_t m[3][3] = { { 0 } };
    int small = !wide && oracle_is_small(dim, n, points, weights), j, k;
    int unit = small ? 0 : oracle_unit(dim, n, points, weights);
    unsigned set, end;
    if (!oracle_find_places(o, dim, n, points, weights)) {
        return 0;
    }
    end = 1u << o->places;
    for (k = 0; k < o->places; k++) {
        const double *p = points + o->owner[k] * dim, weight = weights != NULL ? weights[o->owner[k]] : 0;
        if (small) {
            lift[k] = -(int64_t)weight;
            for (j = 0; j < dim; j++) {
                lift[k] += (int64_t)p[j] * (int64_t)p[j];
            }
            continue;
        }
        oracle_from_double(&big_lift[k], -weight, 2 * unit);
        for (j = 0; j < dim; j++) {
            oracle_from_double(&big_place[k][j], p[j], unit);
            oracle_multiply(&square, &big_place[k][j], &big_place[k][j]);
            oracle_add(&big_lift[k], &square, 1);
        }
    }
    for (set = (2u << dim) - 1; set < end; set = oracle_next_subset(set)) {          /* dim+1 places: determinants */
        int first = -1, row = 0;
        for (k = 0; k < o->places; k++) {
            if (set >> k & 1 && first < 0) {
                first = k;
            } else if (set >> k & 1) {
                for (j = 0; j < dim; j++) {
                    if (small) {
                        m[row][j] = (int64_t)(points[o->owner[k] * dim + j] - points[o->owner[first] * dim + j]);
                    } else {
                        oracle_set(&big[row][j], &big_place[k][j]);
                        oracle_add(&big[row][j], &big_place[first][j], -1);
                    }
                }
                row++;
            }
        }
        if (small) {
            determinant[set] = oracle_small_determinant(dim, m);
            o->simplex[set] = (signed char)((determinant[set] > 0) - (determinant[set] < 0));
        } else {
            oracle_big_determinant(&big_determinant[set], dim, big, 0, (1u << dim) - 1);
            o->simplex[set] = (signed char)big_determinant[set].sign;
        }
    }
    for (set = (4u << dim) - 1; set < end; set = oracle_next_subset(set)) {          /* dim+2: what is below what */
        int signs[ORACLE_POINTS], sign;
        sign = oracle_dependence(o, set, small, determinant, lift, big_determinant, big_lift, signs);
        for (k = 0; k < o->places; k++) {
            if (set >> k & 1 && sign * signs[k] < 0) {
                o->simplex[set & ~(1u << k)] = 0;
            }
        }
    }
    for (set = (2u << dim) - 1; set < end; set = oracle_next_subset(set)) {
        if (o->simplex[set] != 0) {
            o->simplices++;
            o->vertices |= set;
        }
    }
    return 1;
}

/* The dimension that n points span: -1 for none, 0 for one place ... */
static inline int oracle_span(int dim, int n, const double *points)
{
    static oracle_big row[3][3], value, origin;
    int unit = oracle_unit(dim, n, points, NULL), span = n > 0 ? 0 : -1, i, j;
    for (i = 1; i < n && span < dim; i++) {
        int independent = 0;
        unsigned columns;
        for (j = 0; j < dim; j++) {
            oracle_from_double(&row[span][j], points[i * dim + j], unit);
            oracle_from_double(&origin, points[j], unit);
            oracle_add(&row[span][j], &origin, -1);
        }
        for (columns = (2u << span) - 1; columns < 1u << dim; columns = oracle_next_subset(columns)) {
            oracle_big_determinant(&value, span + 1, row, 0, columns);
            independent |= value.sign != 0;
        }
        span += independent;
    }
    return span;
}

/* --- judging a mesh: NULL or the first fault in words --- */

#ifdef PBW_H
static inline const char *oracle_judge(const oracle *o, int n, pbw_status status, const pbw_mesh *mesh)
{
    static unsigned sets[1 << ORACLE_POINTS];
    static int index_of[1 << ORACLE_POINTS];                /* of the simplex with those places, plus 1 */
    int dim = o->dim, corners = dim + 1, hidden = 0, i, k, f;
    if (status != (o->simplices > 0 ? PBW_OK : PBW_DEGENERATE)) {
        return "status";
    }
    if (mesh->dim != dim || mesh->point_count != (size_t)n || mesh->simplex_count != (size_t)o->simplices) {
        return "dim, point_count or simplex_count";
    }
    memset(index_of, 0, sizeof index_of[0] << o->places);
    for (i = 0; i < o->simplices; i++) {
        const pbw_index *corner = mesh->simplices + i * corners;
        int orientation = 1;
        sets[i] = 0;
        for (k = 0; k < corners; k++) {
            if (corner[k] >= (pbw_index)n || o->owner[o->place[corner[k]]] != (int)corner[k]) {
                return "a corner is no point, or a duplicate";
            }
            sets[i] |= 1u << o->place[corner[k]];
            for (f = 0; f < k; f++) {
                orientation = o->place[corner[f]] > o->place[corner[k]] ? -orientation : orientation;
            }
        }
        if (o->simplex[sets[i]] == 0) {
            return "a simplex that should not be";
        }
        if (o->simplex[sets[i]] != orientation) {
            return "orientation";
        }
        if (index_of[sets[i]] != 0) {
            return "a simplex twice";
        }
        index_of[sets[i]] = i + 1;
    }
    for (i = 0; i < o->simplices && mesh->neighbors != NULL; i++) {
        for (k = 0; k < corners; k++) {
            unsigned facet = sets[i] & ~(1u << o->place[mesh->simplices[i * corners + k]]);
            pbw_index across = PBW_NONE;
            for (f = 0; f < o->places; f++) {
                unsigned other = facet | 1u << f;
                if (other != facet && other != sets[i] && index_of[other] != 0) {
                    across = (pbw_index)index_of[other] - 1;
                }
            }
            if (mesh->neighbors[i * corners + k] != across) {
                return "neighbors";
            }
        }
    }
    for (i = 0; i < n; i++) {
        pbw_index first = PBW_NONE;
        if (mesh->canonical[i] != (pbw_index)o->owner[o->place[i]]) {
            return "canonical";
        }
        for (k = o->simplices - 1; k >= 0 && mesh->canonical[i] == (pbw_index)i; k--) {
            first = sets[k] >> o->place[i] & 1 ? (pbw_index)k : first;
        }
        if (mesh->incident[i] != first) {
            return "incident";
        }
    }
    for (k = 0; k < o->places && o->simplices > 0; k++) {
        hidden += !(o->vertices >> k & 1);
    }
    if (mesh->duplicate_count != (size_t)o->duplicates || mesh->hidden_count != (size_t)hidden) {
        return "duplicate_count or hidden_count";
    }
    return NULL;
}
#endif

#endif
