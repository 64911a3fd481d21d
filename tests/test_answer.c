/* test_answer.c: one answer, and the right one.  Random small inputs against the oracle, all of the zoo under
   permutations, strides, floats, flags and threads, and answers known from theory.
       build/test_answer --count 1000000 --seed 7          a long run of random inputs */
#include "pbw_check.h"
#include "meshes.h"
#include "small.h"
#include "test.h"

static const int thread_counts[] = { 2, 3, 4, 7, 8, 16, 64 };

static pbw_options serial(void)
{
    pbw_options options;
    memset(&options, 0, sizeof options);
    options.threads = 1;
    return options;
}

/* --- small inputs against the oracle --- */

static void fill_randomly(small_input *in, uint64_t *state, int dim, int weighted)
{
    unsigned char bytes[512];
    size_t i;
    for (i = 0; i < sizeof bytes; i += 8) {
        uint64_t x = input_next(state);
        memcpy(bytes + i, &x, 8);
    }
    bytes[0] = (unsigned char)((bytes[0] & ~3) | (dim - 2) | weighted << 1);
    small_decode(in, bytes, sizeof bytes);
}

static void test_oracle(void)
{
    static oracle o, wide;
    uint64_t state = test_seed;
    long i;
    if (test_begin("oracle: short and long integers agree")) {
        for (i = 0; i < test_count / 10; i++) {
            small_input in;
            fill_randomly(&in, &state, 2 + (int)(i % 2), (int)(i / 2 % 2));
            if (oracle_is_small(in.dim, in.count, in.points, small_weights(&in))
                && oracle_solve(&o, in.dim, in.count, in.points, small_weights(&in), 0)) {
                oracle_solve(&wide, in.dim, in.count, in.points, small_weights(&in), 1);
                if (!CHECK(memcmp(&o, &wide, sizeof o) == 0)) {
                    small_print(&in);
                }
            }
        }
        test_end();
    }
    if (test_begin("oracle: the diagonal of a square misses its largest point")) {
        static const double square[8] = { 1, 1, 0, 0, 1, 0, 0, 1 };
        CHECK(oracle_solve(&o, 2, 4, square, NULL, 0));
        CHECK_EQUAL(o.simplices, 2);
        CHECK_EQUAL(o.simplex[7], -1);                /* (0,0) (0,1) (1,0), clockwise in this order */
        CHECK_EQUAL(o.simplex[14], 1);                /* (0,1) (1,0) (1,1) */
        test_end();
    }
}

static void test_random(void)
{
    int kind;
    for (kind = 0; kind < 4; kind++) {
        int dim = 2 + kind % 2, weighted = kind / 2;
        if (test_begin("random small inputs: %dD%s", dim, weighted ? ", weighted" : "")) {
            uint64_t state = test_seed * 4 + (uint64_t)kind;
            pbw_options options = serial();
            long i;
            for (i = 0; i < test_count / 4; i++) {
                small_input in;
                const char *fault;
                fill_randomly(&in, &state, dim, weighted);
                fault = small_test(&in, &options, i % 4 == 0);
                if (!CHECK(fault == NULL) && test_faults < 4) {
                    test_say("case %ld, seed %llu: %s", i, (unsigned long long)test_seed, fault);
                    small_print(&in);
                }
            }
            test_end();
        }
    }
}

/* Points within an ulp or so of a line, a plane or a sphere, at any scale; judged by pbw_check. */
static void test_nearly(void)
{
    int dim, shape;
    for (dim = 2; dim <= 3; dim++) {
        for (shape = 0; shape < 6; shape++) {
            static const char *const names[6] = { "on a line through 0", "on a line", "on a line, evenly", "flat",
                                                  "on a sphere", "on a sphere, weights flat" };
            if ((shape != 3 || dim == 3) && test_begin("random inputs nearly %s: %dD", names[shape], dim)) {
                uint64_t state = test_seed * 16 + (uint64_t)(2 * shape + dim);
                pbw_options options = serial();
                double points[3 * 120], weights[120];
                long i;
                for (i = 0; i < test_count / 80; i++) {
                    double a = input_uniform(&state), b = input_uniform(&state), c = shape == 1 ? b : 0;
                    size_t n = 5 + input_below(&state, 115), k;
                    pbw_mesh mesh;
                    const char *fault;
                    int j;
                    input_fill(INPUT_SPHERE, dim, n, input_next(&state), points);
                    for (k = 0; k < n && shape < 4; k++) {
                        double *p = points + k * (size_t)dim;
                        p[0] = shape == 2 ? (double)(k + 1) / (double)n : input_uniform(&state);
                        p[dim - 2] = dim == 3 && shape < 3 ? b * p[0] - c : p[dim - 2];
                        p[dim - 1] = shape == 3 ? a * p[0] + b * p[1] : a * p[0] + c;
                    }
                    j = (int)input_below(&state, 800) - 400;
                    for (k = 0; k < n * (size_t)dim; k++) {
                        points[k] = ldexp(points[k], i % 2 != 0 ? j : 0);
                    }
                    input_fill_weights(INPUT_WEIGHTS_FLAT_ULP, dim, n, 1, points, weights);
                    pbw_triangulate(dim, points, shape == 5 ? weights : NULL, n, &options, &mesh);
                    fault = meshes_fault(&mesh);
                    if (!CHECK(fault == NULL) && test_faults < 4) {
                        test_say("case %ld, seed %llu: %s", i, (unsigned long long)test_seed, fault);
                    }
                    pbw_free(&mesh);
                }
                test_end();
            }
        }
    }
}

/* --- the zoo --- */

static void check_permutations(const zoo_input *in, const pbw_mesh *mesh, uint64_t hash)
{
    pbw_options options = serial();
    size_t n = in->count, dim = (size_t)in->dim, i;
    double *points = (double *)zoo_grow(NULL, (n * dim + 1) * sizeof *points);
    double *weights = (double *)zoo_grow(NULL, (n + 1) * sizeof *weights);
    size_t *from = (size_t *)zoo_grow(NULL, (n + 1) * sizeof *from);
    uint64_t state = test_seed;
    int round;
    for (i = 0; i < n; i++) {
        from[i] = i;
    }
    for (round = 0; round < 3; round++) {
        pbw_mesh other;
        for (i = n; i > 1; i--) {
            size_t j = round == 0 ? (i - 1) / 2 : input_below(&state, (uint32_t)i), swap = from[i - 1];
            from[i - 1] = from[j];
            from[j] = swap;
        }
        for (i = 0; i < n; i++) {
            memcpy(points + i * dim, in->points + from[i] * dim, dim * sizeof *points);
            weights[i] = in->weights != NULL ? in->weights[from[i]] : 0;
        }
        pbw_triangulate(in->dim, points, in->weights != NULL ? weights : NULL, n, &options, &other);
        CHECK(pbw_hash(&other, NULL) == hash);
        if (CHECK_EQUAL(other.simplex_count, mesh->simplex_count) && mesh->duplicate_count == 0) {
            int same = 1;
            for (i = 0; i < mesh->simplex_count * (dim + 1); i++) {
                same &= from[other.simplices[i]] == mesh->simplices[i];
            }
            CHECK(same);                              /* even the order of simplices depends on coordinates alone */
        }
        CHECK_EQUAL(other.duplicate_count, mesh->duplicate_count);
        CHECK_EQUAL(other.hidden_count, mesh->hidden_count);
        pbw_free(&other);
    }
    free(points);
    free(weights);
    free(from);
}

/* The same numbers one after another, with gaps of odd sizes, gives the same arrays. */
static void check_strides(const zoo_input *in, const pbw_mesh *mesh)
{
    pbw_options options = serial();
    size_t n = in->count, bytes = (size_t)in->dim * sizeof(double), i;
    char *rows = (char *)zoo_grow(NULL, n * (bytes + 21) + 1);
    const double *weights;
    pbw_mesh other;
    options.stride = options.weight_stride = bytes + 21;         /* point, 5 bytes of nothing, weight, 8 more */
    memset(rows, 0xff, n * options.stride);
    for (i = 0; i < n; i++) {
        memcpy(rows + i * options.stride, in->points + i * (size_t)in->dim, bytes);
        if (in->weights != NULL) {
            memcpy(rows + i * options.stride + bytes + 5, in->weights + i, sizeof(double));
        }
    }
    weights = in->weights != NULL ? (const double *)(const void *)(rows + bytes + 5) : NULL;
    pbw_triangulate(in->dim, (const double *)(const void *)rows, weights, n, &options, &other);
    CHECK(meshes_equal(mesh, &other));
    pbw_free(&other);
    free(rows);
}

/* pbw_triangulatef of floats is pbw_triangulate of the same numbers as doubles. */
static void check_floats(const zoo_input *in)
{
    pbw_options options = serial();
    size_t n = in->count, dim = (size_t)in->dim, i;
    float *points = (float *)zoo_grow(NULL, (n * dim + 1) * sizeof *points);
    float *weights = (float *)zoo_grow(NULL, (n + 1) * sizeof *weights);
    double *doubles = (double *)zoo_grow(NULL, (n * dim + n + 1) * sizeof *doubles);
    int finite = 1;
    pbw_mesh a, b;
    pbw_status status, other;
    for (i = 0; i < n * dim + n; i++) {
        double x = i < n * dim ? in->points[i] : in->weights != NULL ? in->weights[i - n * dim] : 0;
        finite &= x >= -3e38 && x <= 3e38;
        x = x >= -3e38 && x <= 3e38 ? x : 1;
        doubles[i] = (double)(float)x;
        if (i < n * dim) {
            points[i] = (float)x;
        } else {
            weights[i - n * dim] = (float)x;
        }
    }
    if (finite) {
        status = pbw_triangulatef(in->dim, points, in->weights != NULL ? weights : NULL, n, &options, &a);
        other = pbw_triangulate(in->dim, doubles, in->weights != NULL ? doubles + n * dim : NULL, n, &options, &b);
        CHECK_EQUAL(status, other);
        CHECK(meshes_equal(&a, &b));
        CHECK(pbw_hash(&a, NULL) == pbw_hash(&b, NULL));
        CHECK(meshes_fault(&a) == NULL);
        pbw_free(&a);
        pbw_free(&b);
    }
    free(points);
    free(weights);
    free(doubles);
}

static void check_flags_and_threads(const zoo_input *in, pbw_mesh *mesh, uint64_t hash)
{
    const pbw_index *neighbors = mesh->neighbors;
    pbw_options options = serial();
    pbw_mesh other, again;
    options.flags = PBW_NO_NEIGHBORS;
    meshes_make(in, &options, &other);
    CHECK(other.neighbors == NULL);
    mesh->neighbors = NULL;
    CHECK(meshes_equal(mesh, &other));
    mesh->neighbors = neighbors;
    pbw_free(&other);
    options.flags = PBW_ANY_ORDER;
    meshes_make(in, &options, &other);
    meshes_make(in, &options, &again);
    CHECK(pbw_hash(&other, NULL) == hash);
    CHECK(meshes_fault(&other) == NULL);
    CHECK(meshes_equal(&other, &again));
    pbw_free(&other);
    pbw_free(&again);
    options.flags = 0;
    options.threads = 3;
    meshes_make(in, &options, &other);
    CHECK(meshes_equal(mesh, &other));
    pbw_free(&other);
}

static void check_zoo_input(const zoo_input *in)
{
    static oracle o;
    pbw_options options = serial();
    pbw_mesh mesh;
    pbw_status status = meshes_make(in, &options, &mesh);
    const char *fault;
    uint64_t hash;
    if (!in->finite) {
        CHECK_EQUAL(status, PBW_ERROR_NOT_FINITE);
        CHECK(meshes_is_empty(&mesh));
        return;
    }
    CHECK_EQUAL(status, oracle_span(in->dim, (int)in->count, in->points) == in->dim ? PBW_OK : PBW_DEGENERATE);
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        return;
    }
    fault = meshes_fault(&mesh);
    if (!CHECK(fault == NULL)) {
        test_say("%s", fault);
    }
    if (in->simplices != 0) {
        CHECK_EQUAL(mesh.simplex_count, in->simplices);
    }
    if (in->count <= 64 && oracle_solve(&o, in->dim, (int)in->count, in->points, in->weights, 0)) {
        CHECK(oracle_judge(&o, (int)in->count, status, &mesh) == NULL);
    }
    CHECK(meshes_in_order(&mesh));
    hash = pbw_hash(&mesh, NULL);
    check_permutations(in, &mesh, hash);
    check_strides(in, &mesh);
    check_floats(in);
    check_flags_and_threads(in, &mesh, hash);
    pbw_free(&mesh);
}

static void test_zoo(void)
{
    zoo animals;
    size_t i;
    zoo_fill(&animals);
    for (i = 0; i < animals.count; i++) {
        if (test_begin("zoo: %s", animals.items[i].name)) {
            check_zoo_input(animals.items + i);
            test_end();
        }
    }
    zoo_free(&animals);
}

/* --- known answers --- */

/* Six times the volume (twice the area) of all simplices, for integer coordinates. */
static int64_t whole_volume(const pbw_mesh *mesh)
{
    int64_t sum = 0;
    size_t i;
    int j, k;
    for (i = 0; i < mesh->simplex_count; i++) {
        const pbw_index *corner = mesh->simplices + i * (size_t)(mesh->dim + 1);
        int64_t m[3][3] = { { 0 } };
        for (k = 0; k < mesh->dim; k++) {
            for (j = 0; j < mesh->dim; j++) {
                m[k][j] = (int64_t)(mesh->points[(int)corner[k + 1] * mesh->dim + j]
                                    - mesh->points[(int)corner[0] * mesh->dim + j]);
            }
        }
        sum += oracle_small_determinant(mesh->dim, m);
    }
    return sum;
}

static void test_known(void)
{
    pbw_mesh mesh;
    zoo z;
    int n;
    if (test_begin("known: the square is cut by the rule for ties")) {
        static const double square[8] = { 1, 1, 0, 0, 1, 0, 0, 1 };
        CHECK_EQUAL(pbw_triangulate(2, square, NULL, 4, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(mesh.simplex_count, 2);
        CHECK_EQUAL(mesh.simplices[0] + mesh.simplices[1] + mesh.simplices[2]
                    + mesh.simplices[3] + mesh.simplices[4] + mesh.simplices[5], 0 + 1 + 2 + 3 + 2 + 3);
        pbw_free(&mesh);
        test_end();
    }
    if (test_begin("known: five points in space, the quick start")) {
        static const double points[15] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1 };
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, 5, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(mesh.simplex_count, 2);
        pbw_free(&mesh);
        test_end();
    }
    if (test_begin("known: volumes of lattices")) {
        for (n = 2; n <= 12; n++) {
            memset(&z, 0, sizeof z);
            zoo_new(&z, 3, "box"), zoo_grid(&z, n, 3, 4, 1);
            CHECK_EQUAL(meshes_make(zoo_last(&z), NULL, &mesh), PBW_OK);
            CHECK_EQUAL(whole_volume(&mesh), 6 * (n - 1) * 2 * 3);
            pbw_free(&mesh);
            zoo_new(&z, 2, "rectangle"), zoo_grid(&z, n, 7, 1, 3);
            CHECK_EQUAL(meshes_make(zoo_last(&z), NULL, &mesh), PBW_OK);
            CHECK_EQUAL(whole_volume(&mesh), 2 * (n - 1) * 6 * 9);
            CHECK_EQUAL(mesh.simplex_count, 2 * (n - 1) * 6);
            pbw_free(&mesh);
            zoo_free(&z);
        }
        test_end();
    }
    if (test_begin("known: a heavy point hides the others, a light one is hidden")) {
        double points[15] = { 0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0, 4, 1, 1, 1 }, weights[5] = { 0, 0, 0, 0, -100 };
        CHECK_EQUAL(pbw_triangulate(3, points, weights, 5, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(mesh.simplex_count, 1);
        CHECK_EQUAL(mesh.hidden_count, 1);
        CHECK(mesh.incident[4] == PBW_NONE && mesh.canonical[4] == 4);
        pbw_free(&mesh);
        weights[4] = 0;
        CHECK_EQUAL(pbw_triangulate(3, points, weights, 5, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(mesh.simplex_count, 4);
        CHECK_EQUAL(mesh.hidden_count, 0);
        pbw_free(&mesh);
        test_end();
    }
    if (test_begin("known: duplicates, by weight and by index")) {
        static const double points[18] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, -0.0, -0.0, 0, 0, 0, 1, 0, 0, -0.0 };
        static const double weights[6] = { 1, 0, 0, 2, 0, 2 };
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, 6, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(mesh.duplicate_count, 2);
        CHECK(mesh.canonical[0] == 0 && mesh.canonical[3] == 0 && mesh.canonical[5] == 0);
        pbw_free(&mesh);
        CHECK_EQUAL(pbw_triangulate(3, points, weights, 6, NULL, &mesh), PBW_OK);
        CHECK(mesh.duplicate_count == 2 && mesh.hidden_count == 0);
        CHECK(mesh.canonical[0] == 3 && mesh.canonical[3] == 3 && mesh.canonical[5] == 3);
        CHECK(mesh.incident[0] == PBW_NONE && mesh.incident[3] == 0);
        pbw_free(&mesh);
        test_end();
    }
    if (test_begin("known: equal weights of any size change no simplex")) {
        double points[300], weights[100];
        pbw_mesh plain;
        int i;
        input_fill(INPUT_UNIFORM, 3, 100, test_seed, points);
        pbw_triangulate(3, points, NULL, 100, NULL, &plain);
        for (n = -300; n <= 300; n += 50) {
            for (i = 0; i < 100; i++) {
                weights[i] = n == 0 ? 0 : n < 0 ? -ldexp(1, -n) : ldexp(1, n);
            }
            pbw_triangulate(3, points, weights, 100, NULL, &mesh);
            CHECK(mesh.simplex_count == plain.simplex_count
                  && memcmp(mesh.simplices, plain.simplices, plain.simplex_count * 4 * sizeof(pbw_index)) == 0);
            CHECK((pbw_hash(&mesh, NULL) == pbw_hash(&plain, NULL)) == (n == 0));
            pbw_free(&mesh);
        }
        pbw_free(&plain);
        test_end();
    }
    if (test_begin("known: scaling by powers of two changes no simplex")) {
        double points[300], scaled[300];
        pbw_mesh plain;
        int i;
        input_fill(INPUT_LATTICE, 3, 100, test_seed, points);
        pbw_triangulate(3, points, NULL, 100, NULL, &plain);
        for (n = -1070; n <= 1015; n += 139) {
            for (i = 0; i < 300; i++) {
                scaled[i] = ldexp(points[i], n);
            }
            CHECK_EQUAL(pbw_triangulate(3, scaled, NULL, 100, NULL, &mesh), PBW_OK);
            CHECK(mesh.simplex_count == plain.simplex_count
                  && memcmp(mesh.simplices, plain.simplices, plain.simplex_count * 4 * sizeof(pbw_index)) == 0);
            pbw_free(&mesh);
        }
        pbw_free(&plain);
        test_end();
    }
}

/* --- threads --- */

static void test_threads(void)
{
    static const int kinds[] = { INPUT_UNIFORM, INPUT_SPHERE, INPUT_CLUSTERS, INPUT_LATTICE, INPUT_LINES,
                                 INPUT_PLANE };
    const size_t most = 50000;
    size_t i, t;
    double *points = (double *)zoo_grow(NULL, most * 3 * sizeof *points);
    double *weights = (double *)zoo_grow(NULL, most * sizeof *weights);
    int dim, weighted;
    for (dim = 2; dim <= 3; dim++) {
        for (i = 0; i < 2 * sizeof kinds / sizeof kinds[0]; i++) {
            int kind = kinds[i / 2];
            const size_t n = kind == INPUT_LINES ? most : 20000;       /* in space, extremes come before two levels */
            weighted = i % 2 != 0;
            if (weighted && kind != INPUT_UNIFORM) {
                continue;
            }
            if (test_begin("threads: %dD %s%s", dim, input_name(kind), weighted ? ", weighted" : "")) {
                pbw_options options = serial();
                pbw_mesh one, other;
                input_fill(kind, dim, n, test_seed, points);
                input_fill_weights(INPUT_WEIGHTS_HIDING, dim, n, test_seed, points, weights);
                CHECK_EQUAL(pbw_triangulate(dim, points, weighted ? weights : NULL, n, &options, &one), PBW_OK);
                CHECK(meshes_fault(&one) == NULL);
                CHECK(meshes_in_order(&one));
                for (t = kind == INPUT_LINES ? 4 : 0; t < sizeof thread_counts / sizeof thread_counts[0]; t++) {
                    options.threads = thread_counts[t];
                    CHECK_EQUAL(pbw_triangulate(dim, points, weighted ? weights : NULL, n, &options, &other), PBW_OK);
                    CHECK(meshes_equal(&one, &other));
                    pbw_free(&other);
                }
                pbw_free(&one);
                test_end();
            }
        }
    }
    free(points);
    free(weights);
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 20000);
    test_oracle();
    test_random();
    test_nearly();
    test_known();
    test_zoo();
    test_threads();
    return test_finish();
}
