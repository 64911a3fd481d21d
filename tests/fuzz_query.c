/* fuzz_query.c: small inputs decoded from bytes, and queries at their vertices, between them, outside and not finite,
   judged by exact orientations and by each other.
       make fuzz            libFuzzer where clang is installed, else random bytes
       cc -O2 -I. -Iexamples/lib -DFUZZ_MAIN tests/fuzz_query.c -o fuzz -lm -lpthread && ./fuzz --count 100000 --seed 1 */
#define PBW_IMPLEMENTATION
#define PBW_QUERY_IMPLEMENTATION
#include "pbw_query.h"
#if defined(__clang__)                                 /* coverage of the library is to guide the fuzzer, not ours */
#pragma clang attribute push(__attribute__((no_sanitize("coverage"))), apply_to = function)
#endif
#include "meshes.h"
#include "small.h"
#include "fuzz.h"
#if defined(__clang__)
#pragma clang attribute pop
#endif

enum { QUERIES = 12 };

static int contains(const pbw_mesh *mesh, size_t t, const double *p)
{
    const size_t dim = (size_t)mesh->dim;
    size_t i, k;
    for (i = 0; i <= dim; i++) {
        const double *x[4];
        for (k = 0; k <= dim; k++) {
            x[k] = k == i ? p : mesh->points + mesh->simplices[t * (dim + 1) + k] * dim;
        }
        if ((dim == 2 ? pbw_orient2(x[0], x[1], x[2]) : pbw_orient3(x[0], x[1], x[2], x[3])) < 0) {
            return 0;
        }
    }
    return 1;
}

/* NULL, or what is wrong with the answers to finite queries. */
static const char *judge(const pbw_mesh *mesh, const double *queries, const pbw_options *options)
{
    const size_t dim = (size_t)mesh->dim;
    pbw_index found[QUERIES], facets[QUERIES], near_ones[3 * QUERIES];
    double distances[3 * QUERIES];
    const char *fault = NULL;
    size_t i, j, t;
    int scheme;
    if (pbw_locate(mesh, queries, QUERIES, options, found, facets) != PBW_OK
        || pbw_nearest(mesh, NULL, queries, QUERIES, 3, options, near_ones, distances) != PBW_OK) {
        return "a status";
    }
    for (i = 0; i < QUERIES; i++) {
        const double *p = queries + i * dim;
        for (t = 0; t < mesh->simplex_count && !contains(mesh, t, p); t++) {
        }
        if (found[i] != (t < mesh->simplex_count ? t : PBW_NONE)
            || found[i] != pbw_locate_one(mesh, p, (pbw_index)i, NULL)) {
            return "another simplex";
        }
        for (j = 0; j + 1 < 3; j++) {
            if (distances[3 * i + j] > distances[3 * i + j + 1] * (1 + 1e-12) && mesh->weights == NULL) {
                return "not in order";
            }
        }
        for (j = 0; j < mesh->point_count && mesh->weights == NULL; j++) {
            double sum = 0;
            for (t = 0; t < dim; t++) {
                const double x = mesh->points[j * dim + t] - p[t];
                sum += x * x;
            }
            if (sum < 1e300 && sum > 1e-280 && near_ones[3 * i] != PBW_NONE
                && sqrt(sum) < distances[3 * i] * (1 - 1e-12)) {
                return "not the nearest";
            }
        }
    }
    for (scheme = 0; scheme < 3 && fault == NULL; scheme++) {
        pbw_lists lists;
        if (pbw_coordinates(mesh, queries, QUERIES, (pbw_scheme)scheme, options, &lists) != PBW_OK) {
            return "a status of weights";
        }
        for (i = 0; i < QUERIES; i++) {
            double sum = 0;
            for (j = lists.first[i]; j < lists.first[i + 1]; j++) {
                sum += lists.value[j];
                fault = lists.value[j] >= 0 ? fault : "a negative weight";
            }
            fault = (lists.first[i] == lists.first[i + 1]) == (found[i] == PBW_NONE) ? fault : "no weights";
            fault = found[i] == PBW_NONE || fabs(sum - 1) < 1e-12 ? fault : "a sum other than 1";
        }
        pbw_lists_free(&lists);
    }
    return fault;
}

static const char *fuzz(const unsigned char *data, size_t size, int print)
{
    small_input in;
    pbw_options options;
    pbw_mesh mesh;
    pbw_index found[QUERIES];
    const char *fault;
    double queries[3 * QUERIES];
    pbw_status status;
    int i, k;
    memset(&options, 0, sizeof options);
    options.threads = 1;
    small_decode(&in, data, size);
    status = pbw_triangulate(in.dim, in.points, small_weights(&in), (size_t)in.count, &options, &mesh);
    if ((status != PBW_OK && status != PBW_DEGENERATE) || in.count == 0 || size == 0) {
        pbw_free(&mesh);
        return NULL;
    }
    for (i = 0; i < QUERIES; i++) {
        const double *a = in.points + data[(size_t)i % size] % in.count * in.dim;
        const double *b = in.points + data[(size_t)(i * 7) % size] % in.count * in.dim;
        for (k = 0; k < in.dim; k++) {
            queries[i * in.dim + k] = i % 3 == 0 ? a[k] : i % 3 == 1 ? 0.5 * a[k] + 0.5 * b[k] : 2 * a[k] - b[k];
            if (!(fabs(queries[i * in.dim + k]) <= 1.7e308)) {
                queries[i * in.dim + k] = 1;
            }
        }
    }
    fault = judge(&mesh, queries, &options);
    queries[data[0] % (QUERIES * in.dim)] = data[0] % 2 == 0 ? HUGE_VAL : HUGE_VAL - HUGE_VAL;
    if (pbw_locate(&mesh, queries, QUERIES, &options, found, NULL) != PBW_ERROR_NOT_FINITE) {
        fault = "a query that is not finite is answered";
    }
    pbw_free(&mesh);
    if (print) {
        small_print(&in);
    }
    return fault;
}
