/* test_interpolate.c: pbw_coordinates against volumes of cells before and after the query is inserted, in quadruple
   precision where the compiler has it; linear functions; what lies beside the hull and beside nearly flat simplices.

   A cell is a sum of signed orthoschemes: for each simplex of a star and each flag vertex, edge, facet, simplex, the
   one of the centres of those.  That shares neither formula nor order with pbw.h. */
#include "pbw_query.h"
#include "inputs.h"
#include "meshes.h"
#include "test.h"
#include <float.h>

#if defined(__SIZEOF_FLOAT128__)
__extension__ typedef __float128 real;
#define EXACT 1e-13
#else
typedef long double real;
#define EXACT 1e-9
#endif

static real real_size(real x)
{
    return x < 0 ? -x : x;
}

/* The centre of the simplex of `count` + 1 corners, relative to the first: in the span of the others, e[i], with
   equal power; lift[i] = |e[i]|^2 - (w[i] - w[0]).  By elimination in the matrix of products. */
static void centre(int dim, int count, real (*e)[3], const real *lift, real *result)
{
    real g[3][4], factor;
    int i, j, k;
    for (i = 0; i < count; i++) {
        for (j = 0; j < count; j++) {
            g[i][j] = 0;
            for (k = 0; k < dim; k++) {
                g[i][j] += e[i][k] * e[j][k];
            }
        }
        g[i][count] = lift[i] / 2;
    }
    for (i = 0; i < count; i++) {
        for (j = 0; j < count; j++) {
            factor = j != i ? g[j][i] / g[i][i] : 0;
            for (k = 0; k <= count && j != i; k++) {
                g[j][k] -= factor * g[i][k];
            }
        }
    }
    for (k = 0; k < dim; k++) {
        result[k] = 0;
        for (i = 0; i < count; i++) {
            result[k] += g[i][count] / g[i][i] * e[i][k];
        }
    }
}

static real volume_of(int dim, real (*c)[3])
{
    return dim == 2 ? c[0][0] * c[1][1] - c[0][1] * c[1][0]
                    : c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1])
                    - c[0][1] * (c[1][0] * c[2][2] - c[1][2] * c[2][0])
                    + c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0]);
}

/* The volume of a cell times dim!, or -1 if it is unbounded. */
static real cell_volume(const pbw_mesh *mesh, pbw_index v)
{
    const int dim = mesh->dim;
    const size_t corners = (size_t)dim + 1;
    real sum = 0;
    size_t t;
    for (t = 0; t < mesh->simplex_count; t++) {
        const pbw_index *corner = mesh->simplices + t * corners;
        real e[3][3], w[3], c[3][3], row[3][3], lift[3];
        int own = 0, order[3], i, k, flag, sign;
        while (own <= dim && corner[own] != v) {
            own++;
        }
        if (own > dim) {
            continue;
        }
        for (i = 0; i < dim; i++) {
            const size_t u = corner[i < own ? i : i + 1];
            if (mesh->neighbors[t * corners + (size_t)(i < own ? i : i + 1)] == PBW_NONE) {
                return -1;
            }
            w[i] = mesh->weights != NULL ? (real)mesh->weights[u] - (real)mesh->weights[v] : 0;
            for (k = 0; k < dim; k++) {
                e[i][k] = (real)mesh->points[u * (size_t)dim + (size_t)k]
                        - (real)mesh->points[v * (size_t)dim + (size_t)k];
            }
        }
        for (flag = 0; flag < (dim == 2 ? 2 : 6); flag++) {          /* all orders of the other corners */
            order[0] = flag % dim;
            order[1] = dim == 2 ? 1 - order[0] : (order[0] + 1 + flag / 3) % 3;
            order[2] = 3 - order[0] - order[1];
            for (i = 0; i < dim; i++) {
                lift[i] = -w[order[i]];
                for (k = 0; k < dim; k++) {
                    row[i][k] = e[order[i]][k];
                    lift[i] += row[i][k] * row[i][k];
                }
                centre(dim, i + 1, row, lift, c[i]);
            }
            sign = volume_of(dim, row) > 0 ? 1 : -1;
            sum += sign * volume_of(dim, c);
        }
    }
    return sum;
}

/* Compares the Sibson weights of one query with volumes; 0 if some cell is unbounded.  jitter: the volumes are those
   of points that far off, where the centres of flat simplices would take more than quadruple precision. */
static int check_volumes(const pbw_mesh *mesh, const double *q, const pbw_lists *lists, size_t i, double jitter)
{
    const size_t dim = (size_t)mesh->dim, n = mesh->point_count;
    double *points = (double *)malloc((n + 1) * dim * sizeof *points), *weights = NULL;
    const double most = jitter > 0 ? 1e-9 : 1e-10 > EXACT ? 1e-10 : EXACT;
    uint64_t state = 3;
    pbw_mesh old, after;
    real total = 0, part[64], before[64];
    size_t j, first = lists->first[i], count = lists->first[i + 1] - first;
    int bounded;
    memcpy(points, mesh->points, n * dim * sizeof *points);
    for (j = 0; j < n * dim; j++) {
        points[j] += jitter * input_uniform(&state);
    }
    memcpy(points + n * dim, q, dim * sizeof *points);
    if (mesh->weights != NULL) {
        weights = (double *)malloc((n + 1) * sizeof *weights);
        memcpy(weights, mesh->weights, n * sizeof *weights);
        weights[n] = 0;
    }
    CHECK_EQUAL(pbw_triangulate(mesh->dim, points, weights, n, NULL, &old), PBW_OK);
    CHECK_EQUAL(pbw_triangulate(mesh->dim, points, weights, n + 1, NULL, &after), PBW_OK);
    bounded = count <= 64 && after.incident[n] != PBW_NONE;          /* not hidden, no duplicate */
    for (j = 0; j < count && bounded; j++) {
        const pbw_index v = lists->item[first + j];
        before[j] = old.incident[v] == PBW_NONE ? 0 : cell_volume(&old, v);
        part[j] = after.incident[v] == PBW_NONE ? 0 : cell_volume(&after, v);
        bounded = before[j] >= 0 && part[j] >= 0;
        total += before[j] - part[j];
    }
    for (j = 0; j < count && bounded; j++) {
        const real error = (real)lists->value[first + j] - (before[j] - part[j]) / total;
        if (!CHECK(real_size(error) <= (real)most)) {
            test_say("error %g of %g", (double)error, lists->value[first + j]);
        }
    }
    pbw_free(&old);
    pbw_free(&after);
    free(points);
    free(weights);
    return bounded;
}

/* Weights are positive, in order, sum to 1 and have the query as their mean. */
static void check_linear(const pbw_mesh *mesh, const double *q, const pbw_lists *lists, size_t i, double scale)
{
    const size_t dim = (size_t)mesh->dim;
    real sum = 0, mean[3] = { 0, 0, 0 };
    size_t j, k;
    for (j = lists->first[i]; j < lists->first[i + 1]; j++) {
        CHECK(lists->value[j] > 0 && lists->value[j] <= 1);
        CHECK(j == lists->first[i] || lists->item[j] > lists->item[j - 1]);
        sum += (real)lists->value[j];
        for (k = 0; k < dim; k++) {
            mean[k] += (real)lists->value[j] * ((real)mesh->points[lists->item[j] * dim + k] - (real)q[k]);
        }
    }
    CHECK(real_size(sum - 1) <= (real)1e-14);
    for (k = 0; k < dim; k++) {
        if (!CHECK(real_size(mean[k]) <= (real)(1e-12 * scale))) {
            test_say("off by %g", (double)mean[k]);
        }
    }
}

static void test_random(void)
{
    static const int kinds[] = { INPUT_UNIFORM, INPUT_LATTICE, INPUT_CLUSTERS, INPUT_SPHERE, INPUT_PLANE,
                                 INPUT_ANISOTROPIC, INPUT_LINES };
    static const int weightings[] = { -1, INPUT_WEIGHTS_HIDING, INPUT_WEIGHTS_HALF, INPUT_WEIGHTS_LEVELS };
    enum { N = 500, QUERIES = 150 };
    double points[3 * N], queries[3 * QUERIES], weights[N];
    size_t kind, weighting, i;
    int dim, scheme;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < sizeof kinds / sizeof *kinds; kind++) {
            for (weighting = 0; weighting < sizeof weightings / sizeof *weightings; weighting++) {
                pbw_mesh mesh;
                pbw_index place[QUERIES];
                int w = weightings[weighting], compared = 0;
                if (!test_begin("%dD %s, weights %s", dim, input_name(kinds[kind]),
                                w < 0 ? "none" : input_weights_name(w))) {
                    continue;
                }
                input_fill(kinds[kind], dim, N, test_seed, points);
                input_fill(kinds[kind], dim, QUERIES, test_seed + 1, queries);
                for (i = 0; i < QUERIES * (size_t)dim; i++) {        /* some inside of the others' hull */
                    queries[i] = kinds[kind] == INPUT_LATTICE ? queries[i] / 2 + 1
                               : i / (size_t)dim % 3 != 0 ? queries[i] : 0.5 * queries[i] + 0.5 * points[i];
                }
                if (w >= 0) {
                    input_fill_weights(w, dim, N, test_seed, points, weights);
                }
                CHECK_EQUAL(pbw_triangulate(dim, points, w < 0 ? NULL : weights, N, NULL, &mesh), PBW_OK);
                CHECK_EQUAL(pbw_locate(&mesh, queries, QUERIES, NULL, place, NULL), PBW_OK);
                for (scheme = 0; scheme < 3; scheme++) {
                    pbw_lists lists;
                    CHECK_EQUAL(pbw_coordinates(&mesh, queries, QUERIES, (pbw_scheme)scheme, NULL, &lists), PBW_OK);
                    for (i = 0; i < lists.count && test_faults < 5; i++) {
                        const double *q = queries + i * (size_t)dim;
                        CHECK_EQUAL(lists.first[i] == lists.first[i + 1], place[i] == PBW_NONE);
                        if (place[i] != PBW_NONE) {
                            check_linear(&mesh, q, &lists, i, kinds[kind] == INPUT_LATTICE ? 20 : 1);
                            if (scheme == PBW_SIBSON && i % 10 == 0) {
                                compared += check_volumes(&mesh, q, &lists, i, 0);
                            }
                        }
                    }
                    pbw_lists_free(&lists);
                }
                if (test_verbose) {
                    test_say("%d compared with volumes", compared);
                }
                pbw_free(&mesh);
                test_end();
            }
        }
    }
}

/* Queries beside the hull, beside twins, amid nearly cospherical points: far points make all cells bounded. */
static void test_hard(void)
{
    static const double golden = 1.618033988749895;
    double points[3 * 80], queries[3 * 40];
    int dim, which, far, i, k, n, m;
    for (dim = 2; dim <= 3; dim++) {
        for (which = 0; which < 4; which++) {
            for (far = 0; far < 2; far++) {
                static const char *const names[] = { "round", "twins of 1e-9", "a sliver", "beside the hull" };
                uint64_t state = 7;
                pbw_mesh mesh;
                pbw_lists lists;
                int scheme, compared = 0;
                if (!test_begin("%dD %s%s", dim, names[which], far ? ", amid far points" : "")) {
                    continue;
                }
                n = m = 0;
                for (i = 0; i < 12 && which < 3; i++) {              /* an icosahedron, a polygon */
                    double *p = points + dim * n++, s = i & 1 ? 1 : -1, t = i & 2 ? golden : -golden;
                    if (dim == 3) {
                        p[i / 4] = 0, p[(i / 4 + 1) % 3] = s, p[(i / 4 + 2) % 3] = t;
                    } else {
                        input_turn(i / 12.0, p, p + 1);
                    }
                }
                for (i = 0; i < 12 && which == 1; i++, n++) {
                    for (k = 0; k < dim; k++) {
                        points[dim * n + k] = points[dim * i + k] + 1e-9 * input_uniform(&state);
                    }
                }
                for (i = 0; i < (dim == 3 ? 8 : 4) && (which == 3 || far); i++, n++) {
                    for (k = 0; k < dim; k++) {
                        points[dim * n + k] = (which == 3 && !far ? 1 : 30 + input_uniform(&state))
                                            * (i >> k & 1 ? 1 : -1);
                    }
                }
                for (i = 0; i < 6 && which >= 2; i++, n++) {
                    for (k = 0; k < dim; k++) {
                        points[dim * n + k] = k + 1 == dim && which == 2 ? 1e-12 * input_uniform(&state)
                                            : input_uniform(&state) - 0.5;
                    }
                }
                for (i = 0; i < 40; i++, m++) {
                    static const double towards[] = { 1e-9, 1 - 1e-9, 1 - 1e-13, 0.5 };
                    double shrink = i == 0 ? 0 : towards[i % 4];
                    for (k = 0; k < dim; k++) {
                        double mean = 0.3 * points[k] + 0.3 * points[dim + k] + 0.4 * points[dim * (i % n) + k];
                        queries[dim * m + k] = shrink * mean;
                    }
                }
                CHECK_EQUAL(pbw_triangulate(dim, points, NULL, (size_t)n, NULL, &mesh), PBW_OK);
                for (scheme = 0; scheme < 3; scheme++) {
                    CHECK_EQUAL(pbw_coordinates(&mesh, queries, (size_t)m, (pbw_scheme)scheme, NULL, &lists), PBW_OK);
                    for (i = 0; i < m; i++) {
                        if (lists.first[i] < lists.first[i + 1]) {
                            check_linear(&mesh, queries + dim * i, &lists, (size_t)i, 1);
                            if (scheme == PBW_SIBSON) {
                                compared += check_volumes(&mesh, queries + dim * i, &lists, (size_t)i,
                                                          which == 0 ? 1e-11 : 0);
                            }
                        }
                    }
                    pbw_lists_free(&lists);
                }
                CHECK(!far || compared >= 10);
                pbw_free(&mesh);
                test_end();
            }
        }
    }
}

/* What is known: corners, edges, the middle of a cube and of regular bodies, a point outside. */
static void test_known(void)
{
    double points[3 * 8], queries[3 * 4] = { 0, 0, 0, 0.5, 0, 0, 0.5, 0.5, 0.5, 2, 0, 0 };
    pbw_mesh mesh;
    int i, k, scheme;
    if (!test_begin("a cube")) {
        return;
    }
    for (i = 0; i < 24; i++) {
        points[i] = i / 3 >> i % 3 & 1;
    }
    CHECK_EQUAL(pbw_triangulate(3, points, NULL, 8, NULL, &mesh), PBW_OK);
    for (scheme = 0; scheme < 3; scheme++) {
        pbw_lists lists;
        CHECK_EQUAL(pbw_coordinates(&mesh, queries, 4, (pbw_scheme)scheme, NULL, &lists), PBW_OK);
        CHECK(lists.count == 4 && lists.first[0] == 0 && lists.first[1] == 1 && lists.first[2] == 3);
        CHECK(lists.item[0] == 0 && lists.value[0] == 1);
        CHECK(lists.item[1] == 0 && lists.item[2] == 1 && lists.value[1] == 0.5 && lists.value[2] == 0.5);
        CHECK_EQUAL(lists.first[4], lists.first[3]);
        CHECK(scheme == PBW_BARYCENTRIC || lists.first[3] - lists.first[2] == 8);
        for (k = 0; k < 8 && scheme != PBW_BARYCENTRIC && test_faults == 0; k++) {
            CHECK(fabs(lists.value[3 + k] - 0.125) < 1e-15);
        }
        pbw_lists_free(&lists);
    }
    pbw_free(&mesh);
    test_end();
}

/* Extreme coordinates and all shapes of the zoo: nothing but the promises. */
static void test_zoo(void)
{
    zoo animals;
    size_t i, j, k;
    int scheme;
    zoo_fill(&animals);
    for (i = 0; i < animals.count; i++) {
        const zoo_input *in = animals.items + i;
        if (in->finite && in->count < 3000 && in->count > 0 && test_begin("zoo: %s", in->name)) {
            double queries[3 * 24];
            const size_t dim = (size_t)in->dim;
            pbw_mesh mesh;
            meshes_make(in, NULL, &mesh);
            for (j = 0; j < 24; j++) {
                for (k = 0; k < dim; k++) {
                    const double a = in->points[(j * 7 % in->count) * dim + k];
                    const double b = in->points[(j * 11 % in->count) * dim + k];
                    queries[j * dim + k] = j % 2 == 0 ? a : 0.25 * a + 0.75 * b;
                }
            }
            for (scheme = 0; scheme < 3; scheme++) {
                pbw_lists lists;
                CHECK_EQUAL(pbw_coordinates(&mesh, queries, 24, (pbw_scheme)scheme, NULL, &lists), PBW_OK);
                for (j = 0; j < 24; j++) {
                    double sum = 0;
                    CHECK(mesh.simplex_count == 0 || j % 2 == 1 || lists.first[j + 1] > lists.first[j]);
                    for (k = lists.first[j]; k < lists.first[j + 1]; k++) {
                        CHECK(lists.value[k] >= 0 && lists.value[k] <= 1);
                        sum += lists.value[k];
                    }
                    CHECK(lists.first[j] == lists.first[j + 1] || fabs(sum - 1) < 1e-14);
                }
                pbw_lists_free(&lists);
            }
            pbw_free(&mesh);
            test_end();
        }
    }
    zoo_free(&animals);
}

/* Coordinates of exponents so far apart that the sum of Laplace's weights overflows before it is divided. */
static void test_overflow(void)
{
    const double points[] = {
        -1.4719407360487959e+261, 4.5145943775619896e-110, -2.2486684558166048e+107, 5.4624596341718132e+219,
        -4.7187180320383459e+60, 2.0651521841201756e+142, 1.0977913378170515e-178, -2.1639506739016808e+147,
        2.9366092014848514e-173, 1.0766764897846969e-231, 5.1599958260811692e+255, 2.9414458616948245e-211,
        -1.721612433832751e+40, 1.6066903237403884e+222, -2381.7281523618108, 1.2930285100417943e+160,
        -1.4838471696180883e-170, -5.2282558389295682e-69, 1.1355748212128024e-14, 3.1233007687605735e-151,
        3.5707303141202582e-77
    };
    const double weights[] = { 1, 1, 4.6826825190795384e+294, 1, 1, 1, -1 };
    const double q[] = { -8.608062169163755e+39, 2.5799979130405846e+255, -1190.8640761809054 };
    int scheme;
    if (test_begin("sums that overflow")) {
        pbw_mesh mesh;
        CHECK_EQUAL(pbw_triangulate(3, points, weights, 7, NULL, &mesh), PBW_OK);
        for (scheme = 0; scheme < 3; scheme++) {
            pbw_lists lists;
            double sum = 0;
            size_t i;
            CHECK_EQUAL(pbw_coordinates(&mesh, q, 1, (pbw_scheme)scheme, NULL, &lists), PBW_OK);
            for (i = 0; i < lists.first[1]; i++) {
                sum += lists.value[i];
            }
            CHECK(fabs(sum - 1) < 1e-12);
            pbw_lists_free(&lists);
        }
        pbw_free(&mesh);
        test_end();
    }
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 1000);
    test_known();
    test_random();
    test_hard();
    test_zoo();
    test_overflow();
    return test_finish();
}
