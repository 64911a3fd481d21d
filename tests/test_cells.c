/* test_cells.c: Voronoi and power cells: whole, closed, symmetric, equal to cells cut by brute force, exact where
   points are degenerate, the same bytes for every number of threads, and sound after every failure. */
#include "pbw_cells.h"
#include "inputs.h"
#include "meter.h"
#include "test.h"
#include "zoo.h"
#include <math.h>

#define ALL (PBW_CELLS_FACETS | PBW_CELLS_SHAPES)

typedef struct sites { int dim; size_t count; double *x, *w; double box[6]; } sites;

static void *take(size_t bytes)
{
    return zoo_grow(NULL, bytes + 1);
}

/* The bounds of the points and `margin` of their extent more. */
static void bound(const sites *s, double margin, double *box)
{
    const size_t dim = (size_t)s->dim;
    double extent = 0;
    size_t i, k;
    for (k = 0; k < dim; k++) {
        box[k] = box[dim + k] = s->count > 0 ? s->x[k] : 0;
        for (i = 0; i < s->count; i++) {
            box[k] = fmin(box[k], s->x[i * dim + k]);
            box[dim + k] = fmax(box[dim + k], s->x[i * dim + k]);
        }
        extent = fmax(extent, box[dim + k] - box[k]);
    }
    for (k = 0; k < dim; k++) {
        const double more = margin * (box[dim + k] > box[k] ? box[dim + k] - box[k] : extent > 0 ? extent : 1);
        box[k] -= more;
        box[dim + k] += more;
    }
}

static sites sites_make(int kind, int dim, size_t count, int weights)
{
    sites s;
    s.dim = dim;
    s.count = count;
    s.x = (double *)take(count * (size_t)dim * sizeof(double));
    s.w = weights != INPUT_WEIGHTS_ZERO ? (double *)take(count * sizeof(double)) : NULL;
    input_fill(kind, dim, count, test_seed, s.x);
    if (s.w != NULL) {
        input_fill_weights(weights, dim, count, test_seed, s.x, s.w);
    }
    bound(&s, 0.05, s.box);
    return s;
}

static void sites_free(sites *s)
{
    free(s->x);
    free(s->w);
}

static double volume_of(int dim, const double *box)
{
    double volume = 1;
    int k;
    for (k = 0; k < dim; k++) {
        volume *= box[dim + k] - box[k];
    }
    return volume;
}

static double sum_of(const pbw_cells *cells)
{
    double sum = 0, lost = 0;
    size_t i;
    for (i = 0; i < cells->cell_count; i++) {        /* Kahan's */
        const double x = cells->volumes[i] - lost, next = sum + x;
        lost = next - sum - x;
        sum = next;
    }
    return sum;
}

/* The normal of a facet of cell i, outward, of length 1. */
static void normal_of(const pbw_mesh *mesh, const pbw_domain *domain, size_t i, pbw_index neighbor, double *n)
{
    const size_t dim = (size_t)mesh->dim;
    double length = 0;
    size_t k;
    for (k = 0; k < dim; k++) {
        if (neighbor < mesh->point_count) {
            n[k] = mesh->points[neighbor * dim + k] - mesh->points[i * dim + k];
        } else if (PBW_NONE - 1 - neighbor < 2 * dim) {
            const pbw_index wall = PBW_NONE - 1 - neighbor;
            n[k] = wall / 2 != k ? 0 : wall % 2 != 0 ? 1 : -1;
        } else {
            n[k] = domain->planes[(PBW_NONE - 1 - neighbor - 2 * dim) * (dim + 1) + k];
        }
        length += n[k] * n[k];
    }
    for (k = 0; k < dim; k++) {
        n[k] /= sqrt(length);
    }
}

static double area_to(const pbw_cells *cells, size_t i, pbw_index j)
{
    double area = 0;
    size_t f;
    for (f = cells->first[i]; f < cells->first[i + 1]; f++) {
        area += cells->neighbors[f] == j ? cells->areas[f] : 0;
    }
    return area;
}

/* How far the area of a bounded facet along its normal n is from what its loop encloses. */
static double loop_fault(const pbw_cells *cells, size_t f, const double *n)
{
    const size_t dim = (size_t)cells->dim, first = cells->loop_first[f], end = cells->loop_first[f + 1];
    const double *o = cells->vertices + cells->loops[first] * dim;
    double sum[3] = { 0, 0, 0 }, worst = 0;
    size_t l, k;
    for (l = first + 1; l + (dim == 3) < end; l++) {
        const double *a = cells->vertices + cells->loops[l] * dim;
        const double *b = dim == 3 ? cells->vertices + cells->loops[l + 1] * dim : a;
        for (k = 0; k < dim && dim == 3; k++) {
            const size_t u = (k + 1) % 3, v = (k + 2) % 3;
            sum[k] += ((a[u] - o[u]) * (b[v] - o[v]) - (a[v] - o[v]) * (b[u] - o[u])) / 2;
        }
        if (dim == 2) {
            sum[0] += a[1] - o[1];
            sum[1] -= a[0] - o[0];
        }
    }
    for (k = 0; k < dim; k++) {
        worst = fmax(worst, fabs(sum[k] - cells->areas[f] * n[k]));
    }
    return worst;
}

/* Areas times normals add up to 0, loops enclose them, and what i says of its facet with j, j says of its facet with
   i.  Returns the largest fault, relative to the extent of the box. */
static double faults_of(const pbw_mesh *mesh, const pbw_domain *domain, const pbw_cells *cells, double extent)
{
    const double unit = mesh->dim == 3 ? extent * extent : extent;
    double worst = 0;
    size_t i, f;
    int k;
    for (i = 0; i < cells->cell_count; i++) {
        double sum[3] = { 0, 0, 0 }, n[3];
        if (cells->volumes[i] >= HUGE_VAL) {
            continue;
        }
        for (f = cells->first[i]; f < cells->first[i + 1]; f++) {
            const pbw_index j = cells->neighbors[f];
            normal_of(mesh, domain, i, j, n);
            for (k = 0; k < mesh->dim; k++) {
                sum[k] += cells->areas[f] * n[k];
            }
            if (cells->loops != NULL) {
                worst = fmax(worst, loop_fault(cells, f, n) / unit);
            }
            if (j < mesh->point_count && cells->volumes[j] < HUGE_VAL) {
                worst = fmax(worst, fabs(area_to(cells, j, (pbw_index)i) - cells->areas[f]) / unit);
            }
        }
        for (k = 0; k < mesh->dim; k++) {
            worst = fmax(worst, fabs(sum[k]) / unit);
        }
    }
    return worst;
}

static double thinnest_of(const sites *s)
{
    double extent = HUGE_VAL;
    int k;
    for (k = 0; k < s->dim; k++) {
        extent = fmin(extent, s->box[s->dim + k] - s->box[k]);
    }
    return extent;
}

static double extent_of(const sites *s)
{
    double extent = 0;
    int k;
    for (k = 0; k < s->dim; k++) {
        extent = fmax(extent, s->box[s->dim + k] - s->box[k]);
    }
    return extent;
}

static int equal(const void *a, const void *b, size_t bytes)
{
    return bytes == 0 || (a == NULL) != (b == NULL) ? a == b || bytes == 0 : memcmp(a, b, bytes) == 0;
}

static int same_volumes(const pbw_cells *a, const pbw_cells *b)
{
    const size_t n = a->cell_count;
    return n == b->cell_count && equal(a->volumes, b->volumes, n * sizeof(double))
           && equal(a->centroids, b->centroids, n * (size_t)a->dim * sizeof(double));
}

/* The differences of volumes, and of centroids times volumes, added up, relative to a box. */
static double differ(const pbw_cells *a, const pbw_cells *b, const double *box)
{
    const size_t dim = (size_t)a->dim;
    double sum = 0;
    size_t i, k;
    for (i = 0; i < a->cell_count; i++) {
        sum += fabs(a->volumes[i] - b->volumes[i]);
        for (k = 0; k < dim; k++) {
            sum += fabs(a->centroids[i * dim + k] - b->centroids[i * dim + k]) / (box[dim + k] - box[k])
                   * b->volumes[i];
        }
    }
    return sum / volume_of(a->dim, box);
}

static int same_cells(const pbw_cells *a, const pbw_cells *b)
{
    const size_t dim = (size_t)a->dim, n = a->facet_count;
    return same_volumes(a, b) && n == b->facet_count && a->vertex_count == b->vertex_count
           && a->ray_count == b->ray_count && equal(a->first, b->first, (a->cell_count + 1) * sizeof(size_t))
           && equal(a->neighbors, b->neighbors, n * sizeof(pbw_index))
           && equal(a->areas, b->areas, n * sizeof(double))
           && equal(a->vertices, b->vertices, a->vertex_count * dim * sizeof(double))
           && equal(a->rays, b->rays, a->ray_count * dim * sizeof(double))
           && (a->loops == NULL || (equal(a->loop_first, b->loop_first, (n + 1) * sizeof(size_t))
                                    && equal(a->loops, b->loops, a->loop_first[n] * sizeof(pbw_index))))
           && (a->shifts == NULL) == (b->shifts == NULL)
           && (a->shifts == NULL || equal(a->shifts, b->shifts, n * dim));
}

static pbw_options threads(int count)
{
    pbw_options options;
    memset(&options, 0, sizeof options);
    options.threads = count;
    return options;
}

/* ---- the volumes of kinds of points */

static void test_kinds(void)
{
    static const int weights[3] = { INPUT_WEIGHTS_ZERO, INPUT_WEIGHTS_HIDING, INPUT_WEIGHTS_HALF };
    int dim, kind, w;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            for (w = 0; w < 3; w++) {
                if (kind != INPUT_MOMENT
                    && test_begin("whole: %dD %s, weights %s", dim, input_name(kind),
                                  input_weights_name(weights[w]))) {
                    sites s = sites_make(kind, dim, TEST_SIZE(3000), weights[w]);
                    const unsigned what = PBW_CELLS_FACETS | (w == 1 ? PBW_CELLS_SHAPES : 0);
                    pbw_options options = threads(2);
                    pbw_domain domain;
                    pbw_mesh mesh;
                    pbw_cells cells, plain, alone;
                    double sum, fault;
                    memset(&domain, 0, sizeof domain);
                    domain.box = s.box;
                    CHECK_EQUAL(pbw_triangulate(dim, s.x, s.w, s.count, &options, &mesh), PBW_OK);
                    CHECK_EQUAL(pbw_cells_of(&mesh, &domain, what, &options, &cells), PBW_OK);
                    CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, &options, &plain), PBW_OK);
                    sum = fmax(fabs(sum_of(&cells) / volume_of(dim, s.box) - 1),
                               fabs(sum_of(&plain) / volume_of(dim, s.box) - 1));
                    fault = faults_of(&mesh, &domain, &cells, extent_of(&s));
                    CHECK(same_volumes(&cells, &plain));
                    pbw_cells_free(&plain);
                    options.threads = 1;
                    CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, &options, &alone), PBW_OK);
                    CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &plain), PBW_OK);
                    CHECK(same_volumes(&alone, &plain));
                    pbw_cells_free(&alone);
                    if (!CHECK(sum < 1e-12)
                        || !CHECK(fault < (kind == INPUT_SPHERE ? 1e-7 : kind == INPUT_LINES ? 1e-10 : 1e-11))) {
                        test_say("volumes %g, areas %g", sum, fault);
                    }
                    pbw_cells_free(&cells);
                    pbw_cells_free(&plain);
                    pbw_free(&mesh);
                    sites_free(&s);
                    test_end();
                }
            }
        }
    }
}

/* ---- the order of facets in space, and their areas from both sides */

static int has_vertex(const pbw_mesh *mesh, size_t simplex, pbw_index v)
{
    const pbw_index *corner = mesh->simplices + 4 * simplex;
    return corner[0] == v || corner[1] == v || corner[2] == v || corner[3] == v;
}

/* Whether the neighbours of each cell are in the order of their first simplices. */
static int in_order(const pbw_mesh *mesh, const pbw_cells *cells)
{
    int good = 1;
    size_t i, f;
    for (i = 0; i < cells->cell_count; i++) {
        size_t s = 0;
        for (f = cells->first[i]; f < cells->first[i + 1]; f++) {
            const pbw_index j = cells->neighbors[f];
            size_t first = 0;
            while (!has_vertex(mesh, first, (pbw_index)i) || !has_vertex(mesh, first, j)) {
                first++;
            }
            good &= first >= s;
            s = first;
        }
    }
    return good;
}

static void test_facet_order(void)
{
    static const int kinds[4] = { INPUT_UNIFORM, INPUT_CLUSTERS, INPUT_TERRAIN, INPUT_LATTICE };
    int i, w;
    for (i = 0; i < 4; i++) {
        for (w = 0; w < 2; w++) {
            if (test_begin("order of facets: %s, weights %d", input_name(kinds[i]), w)) {
                sites s = sites_make(kinds[i], 3, 500, w != 0 ? INPUT_WEIGHTS_HIDING : INPUT_WEIGHTS_ZERO);
                pbw_mesh mesh;
                pbw_cells cells, shapes;
                size_t v, f, pairs = 0, differ = 0;
                CHECK_EQUAL(pbw_triangulate(3, s.x, s.w, s.count, NULL, &mesh), PBW_OK);
                CHECK_EQUAL(pbw_cells_of(&mesh, NULL, PBW_CELLS_FACETS, NULL, &cells), PBW_OK);
                CHECK_EQUAL(pbw_cells_of(&mesh, NULL, ALL, NULL, &shapes), PBW_OK);
                for (v = 0; v < cells.cell_count; v++) {
                    for (f = cells.first[v]; f < cells.first[v + 1]; f++) {
                        const double back = area_to(&cells, cells.neighbors[f], (pbw_index)v);
                        differ += memcmp(&back, cells.areas + f, sizeof back) != 0;
                        pairs++;
                    }
                }
                CHECK(pairs > cells.cell_count);
                CHECK_EQUAL(differ, 0);
                CHECK(in_order(&mesh, &cells));
                CHECK(equal(cells.neighbors, shapes.neighbors, cells.facet_count * sizeof(pbw_index))
                      && equal(cells.areas, shapes.areas, cells.facet_count * sizeof(double)));
                pbw_cells_free(&shapes);
                pbw_cells_free(&cells);
                pbw_free(&mesh);
                sites_free(&s);
                test_end();
            }
        }
    }
}

/* ---- brute force: each facet is a large square in its plane, cut by all other half-spaces (Sutherland, Hodgman) */

enum { BRUTE_PLANES = 80 };
typedef struct brute { int count; double plane[BRUTE_PLANES][4]; pbw_index name[BRUTE_PLANES]; } brute;

static void brute_add(brute *b, double x, double y, double z, double c, pbw_index name)
{
    double *plane = b->plane[b->count];
    plane[0] = x, plane[1] = y, plane[2] = z, plane[3] = c;
    b->name[b->count++] = name;
}

static int brute_clip(double (*polygon)[3], int count, const double *plane)
{
    double next[BRUTE_PLANES + 8][3];
    int i, k, made = 0;
    for (i = 0; i < count; i++) {
        const double *p = polygon[i], *q = polygon[(i + 1) % count];
        const double a = plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] - plane[3];
        const double b = plane[0] * q[0] + plane[1] * q[1] + plane[2] * q[2] - plane[3];
        for (k = 0; a <= 0 && k < 3; k++) {
            next[made][k] = p[k];
        }
        made += a <= 0;
        for (k = 0; (a <= 0) != (b <= 0) && k < 3; k++) {
            next[made][k] = p[k] + a / (a - b) * (q[k] - p[k]);
        }
        made += (a <= 0) != (b <= 0);
    }
    memcpy(polygon, next, (size_t)made * sizeof *next);
    return made;
}

/* The area of facet f; *cone: the volume of its cone over the origin. */
static double brute_area(const brute *b, int f, double size, double *cone)
{
    const double *n = b->plane[f];
    const double square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    double polygon[BRUTE_PLANES + 8][3], u[3] = { 0, 0, 0 }, v[3], area[3] = { 0, 0, 0 }, length;
    int i, k, count = 4, axis = fabs(n[0]) < fabs(n[1]) ? 0 : 1;
    axis = fabs(n[2]) < fabs(n[axis]) ? 2 : axis;
    u[axis] = 1;
    for (k = 0; k < 3; k++) {
        v[k] = n[(k + 1) % 3] * u[(k + 2) % 3] - n[(k + 2) % 3] * u[(k + 1) % 3];
    }
    for (k = 0; k < 3; k++) {
        u[k] = v[(k + 1) % 3] * n[(k + 2) % 3] - v[(k + 2) % 3] * n[(k + 1) % 3];
    }
    length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (i = 0; i < 4; i++) {
        for (k = 0; k < 3; k++) {
            polygon[i][k] = n[k] * n[3] / square + size / length * ((i == 0 || i == 3 ? 1 : -1) * u[k] / sqrt(square)
                                                                    + (i < 2 ? 1 : -1) * v[k]);
        }
    }
    for (i = 0; i < b->count && count > 0; i++) {
        count = i == f ? count : brute_clip(polygon, count, b->plane[i]);
    }
    for (i = 1; i + 1 < count; i++) {
        for (k = 0; k < 3; k++) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            area[k] += (polygon[i][l] - polygon[0][l]) * (polygon[i + 1][m] - polygon[0][m])
                       - (polygon[i][m] - polygon[0][m]) * (polygon[i + 1][l] - polygon[0][l]);
        }
    }
    length = 0.5 * sqrt(area[0] * area[0] + area[1] * area[1] + area[2] * area[2]);
    *cone = length * n[3] / sqrt(square) / 3;
    return length;
}

/* All half-spaces of point i, relative to it; in the plane a slab of height 1. */
static void brute_cell(const sites *s, const pbw_mesh *mesh, size_t i, brute *b)
{
    const double *points = mesh->points;
    const size_t dim = (size_t)s->dim;
    const double *p = points + i * dim;
    size_t j, k;
    b->count = 0;
    for (k = 0; k < 3; k++) {
        const double low = k < dim ? s->box[k] - p[k] : 0, high = k < dim ? s->box[dim + k] - p[k] : 1;
        brute_add(b, -(k == 0), -(k == 1), -(k == 2), -low, (pbw_index)(PBW_NONE - 1 - 2 * k));
        brute_add(b, k == 0, k == 1, k == 2, high, (pbw_index)(PBW_NONE - 2 - 2 * k));
    }
    for (j = 0; j < s->count; j++) {
        double d[3] = { 0, 0, 0 }, square = 0;
        for (k = 0; k < dim; k++) {
            d[k] = points[j * dim + k] - p[k];
            square += d[k] * d[k];
        }
        if (square > 0 && mesh->canonical[j] == j) {
            brute_add(b, d[0], d[1], d[2], (square + (s->w != NULL ? s->w[i] - s->w[j] : 0)) / 2, (pbw_index)j);
        }
    }
}

/* All areas and volumes in s->box; span: do the points span the space? */
static void check_brute(const sites *s, int span, double size)
{
    const int dim = s->dim;
    const double unit = dim == 3 ? size * size : size;
    pbw_domain domain;
    pbw_mesh mesh;
    pbw_cells cells;
    size_t i;
    memset(&domain, 0, sizeof domain);
    domain.box = s->box;
    CHECK_EQUAL(pbw_triangulate(dim, s->x, s->w, s->count, NULL, &mesh), span ? PBW_OK : PBW_DEGENERATE);
    CHECK_EQUAL(pbw_cells_of(&mesh, &domain, PBW_CELLS_FACETS, NULL, &cells), PBW_OK);
    for (i = 0; i < cells.cell_count; i++) {
        double volume = 0, cone;
        brute b;
        int f;
        if (mesh.canonical[i] != i) {
            CHECK(!(cells.volumes[i] > 0) && cells.first[i] == cells.first[i + 1]);
            continue;
        }
        brute_cell(s, &mesh, i, &b);
        for (f = 0; f < b.count; f++) {
            const double area = brute_area(&b, f, size, &cone);
            volume += cone;
            CHECK((dim == 2 && b.name[f] >= PBW_NONE - 6 && b.name[f] <= PBW_NONE - 5)
                  || fabs(area_to(&cells, i, b.name[f]) - area) < 1e-12 * unit);
        }
        CHECK(fabs(cells.volumes[i] - volume) < 1e-12 * unit * size);
    }
    pbw_cells_free(&cells);
    pbw_free(&mesh);
}

static void test_brute(int dim, int kind, int weights, double margin)
{
    sites s = sites_make(kind, dim, 40, weights);
    bound(&s, margin, s.box);
    check_brute(&s, 1, 10 * extent_of(&s));
    sites_free(&s);
}

static void test_brutes(void)
{
    static const int weights[3] = { INPUT_WEIGHTS_ZERO, INPUT_WEIGHTS_HIDING, INPUT_WEIGHTS_HALF };
    int dim, kind, w, tight;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind <= INPUT_LINES; kind++) {
            for (w = 0; w < 3; w++) {
                for (tight = 0; tight < 2; tight++) {
                    if (test_begin("brute force: %dD %s, weights %s, %s", dim, input_name(kind),
                                   input_weights_name(weights[w]), tight ? "box inside the points" : "box")) {
                        test_brute(dim, kind, weights[w], tight ? -0.2 : 0.1);
                        test_end();
                    }
                }
            }
        }
    }
}

/* ---- the true diagram of lattices */

/* Points of an n^3 block of the lattice with the offsets (in halves) in each unit cube, times 2. */
static sites lattice(int dim, int n, const signed char (*offset)[3], int offsets)
{
    sites s;
    int i, j, k, m;
    memset(&s, 0, sizeof s);
    s.dim = dim;
    s.x = (double *)take((size_t)n * (size_t)n * (size_t)n * (size_t)offsets * 3 * sizeof(double));
    for (i = 0; i < n; i++) {
        for (j = 0; j < n; j++) {
            for (k = 0; k < (dim == 3 ? n : 1); k++) {
                for (m = 0; m < offsets; m++) {
                    double *p = s.x + s.count++ * (size_t)dim;
                    p[0] = 2 * i + offset[m][0];
                    p[1] = 2 * j + offset[m][1];
                    p[dim - 1] = dim == 3 ? 2 * k + offset[m][2] : p[1];
                }
            }
        }
    }
    bound(&s, 0.05, s.box);
    return s;
}

static void test_lattice(const char *name, int dim, const signed char (*offset)[3], int offsets, const int *expected)
{
    if (test_begin("lattice: %dD %s", dim, name)) {
        sites s = lattice(dim, 6, offset, offsets);
        pbw_mesh mesh;
        pbw_cells cells;
        size_t i, f, l, m, inner = 0;
        CHECK_EQUAL(pbw_triangulate(dim, s.x, NULL, s.count, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_cells_of(&mesh, NULL, ALL | PBW_CELLS_MERGE, NULL, &cells), PBW_OK);
        for (i = 0; i < s.count; i++) {
            pbw_index corner[64];
            size_t corners = 0;
            int k, inside = 1;
            for (k = 0; k < dim; k++) {
                inside &= s.x[i * (size_t)dim + (size_t)k] >= 4 && s.x[i * (size_t)dim + (size_t)k] <= 7;
            }
            if (!inside) {
                continue;
            }
            inner++;
            for (f = cells.first[i]; f < cells.first[i + 1]; f++) {
                for (l = cells.loop_first[f]; l < cells.loop_first[f + 1]; l++) {
                    for (m = 0; m < corners && corner[m] != cells.loops[l]; m++) {
                    }
                    corner[m] = cells.loops[l];
                    corners += m == corners && corners < 63;
                }
                CHECK(cells.areas[f] > 0);
            }
            CHECK_EQUAL(cells.first[i + 1] - cells.first[i], expected[0]);
            CHECK_EQUAL(corners, expected[1]);
            CHECK(fabs(cells.volumes[i] - (dim == 3 ? 8.0 : 4.0) / offsets) < 1e-13);
        }
        CHECK(inner > 0);
        pbw_cells_free(&cells);
        pbw_free(&mesh);
        sites_free(&s);
        test_end();
    }
}

static void test_lattices(void)
{
    static const signed char sc[1][3] = { { 0, 0, 0 } }, bcc[2][3] = { { 0, 0, 0 }, { 1, 1, 1 } };
    static const signed char fcc[4][3] = { { 0, 0, 0 }, { 1, 1, 0 }, { 1, 0, 1 }, { 0, 1, 1 } };
    static const int square[2] = { 4, 4 }, cube[2] = { 6, 8 }, truncated[2] = { 14, 24 }, rhombic[2] = { 12, 14 };
    test_lattice("square", 2, sc, 1, square);
    test_lattice("cubic", 3, sc, 1, cube);
    test_lattice("body-centred", 3, bcc, 2, truncated);
    test_lattice("face-centred", 3, fcc, 4, rhombic);
}

/* An octahedron in space, a diamond in the plane: |x| + |y| + |z| <= 1. */
static size_t diamond(int dim, double *planes)
{
    size_t i, count = (size_t)1 << dim;
    int k;
    for (i = 0; i < count; i++) {
        for (k = 0; k < dim; k++) {
            planes[i * ((size_t)dim + 1) + (size_t)k] = (i >> k & 1) != 0 ? -1 : 1;
        }
        planes[i * ((size_t)dim + 1) + (size_t)dim] = 1;
    }
    return count;
}

/* ---- cut cells of the true diagram, against all corners that three half-spaces have, in integers.  Coordinates are
   below 2^6 in size, so n < 2^8, c < 2^15, X and D < 2^33, and n.X - c D < 2^43. */

typedef struct halves { int count; int64_t n[160][3], c[160]; pbw_index name[160]; } halves;
typedef struct spot { int64_t x[3], d; } spot;                       /* at x / d */

static void add_half(halves *h, pbw_index name, int64_t x, int64_t y, int64_t z, int64_t c)
{
    h->n[h->count][0] = x;
    h->n[h->count][1] = y;
    h->n[h->count][2] = z;
    h->c[h->count] = c;
    h->name[h->count++] = name;
}

/* The half-spaces around point i: walls and bisectors of all other points; in the plane between z = 0 and 1. */
static halves halves_of(const sites *s, const pbw_mesh *mesh, const pbw_domain *domain, size_t i)
{
    const size_t dim = (size_t)s->dim;
    halves h;
    size_t j, k;
    h.count = 0;
    for (k = 0; k < 2 * dim && domain->box != NULL; k++) {
        const int64_t sign = k % 2 != 0 ? 1 : -1;
        add_half(&h, (pbw_index)(PBW_NONE - 1 - k), k / 2 == 0 ? sign : 0, k / 2 == 1 ? sign : 0,
                 k / 2 == 2 ? sign : 0, sign * (int64_t)domain->box[k / 2 + (k % 2 != 0 ? dim : 0)]);
    }
    for (j = 0; j < domain->plane_count; j++) {
        const double *p = domain->planes + j * (dim + 1);
        add_half(&h, (pbw_index)(PBW_NONE - 1 - 2 * dim - j), (int64_t)p[0], (int64_t)p[1],
                 dim == 3 ? (int64_t)p[2] : 0, (int64_t)p[dim]);
    }
    if (dim == 2) {
        add_half(&h, PBW_NONE, 0, 0, -1, 0);
        add_half(&h, PBW_NONE, 0, 0, 1, 1);
    }
    for (j = 0; j < s->count; j++) {
        int64_t n[3] = { 0, 0, 0 }, c = s->w != NULL ? (int64_t)(s->w[i] - s->w[j]) : 0;
        for (k = 0; k < dim; k++) {
            n[k] = (int64_t)(2 * (s->x[j * dim + k] - s->x[i * dim + k]));
            c += (int64_t)(s->x[j * dim + k] * s->x[j * dim + k] - s->x[i * dim + k] * s->x[i * dim + k]);
        }
        if (mesh->canonical[j] == j && j != i) {
            add_half(&h, (pbw_index)j, n[0], n[1], n[2], c);
        }
    }
    return h;
}

static int64_t half_at(const halves *h, int f, const spot *p)
{
    return h->n[f][0] * p->x[0] + h->n[f][1] * p->x[1] + h->n[f][2] * p->x[2] - h->c[f] * p->d;
}

/* Where three planes meet, d > 0; d = 0: nowhere. */
static spot meet(const halves *h, int a, int b, int c)
{
    const int at[3] = { a, b, c };
    spot p = { { 0, 0, 0 }, 0 };
    int i, k;
    for (i = 0; i < 3; i++) {
        const int64_t *u = h->n[at[(i + 1) % 3]], *v = h->n[at[(i + 2) % 3]];
        for (k = 0; k < 3; k++) {
            const int64_t across = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
            p.x[k] += h->c[at[i]] * across;
            p.d += i == 0 ? h->n[a][k] * across : 0;
        }
    }
    for (k = 0; k < 3 && p.d < 0; k++) {
        p.x[k] = -p.x[k];
    }
    p.d = p.d < 0 ? -p.d : p.d;
    return p;
}

/* The corners of the cell, each once.  Returns how many. */
static int corners_of(const halves *h, spot *corner, int most)
{
    int a, b, c, f, m, count = 0;
    for (a = 0; a < h->count; a++) {
        for (b = a + 1; b < h->count; b++) {
            for (c = b + 1; c < h->count; c++) {
                const spot p = meet(h, a, b, c);
                for (f = 0; f < h->count && p.d != 0 && half_at(h, f, &p) <= 0; f++) {
                }
                for (m = 0; f == h->count && m < count; m++) {
                    if (p.x[0] * corner[m].d == corner[m].x[0] * p.d && p.x[1] * corner[m].d == corner[m].x[1] * p.d
                        && p.x[2] * corner[m].d == corner[m].x[2] * p.d) {
                        break;
                    }
                }
                if (f == h->count && m == count && count < most) {
                    corner[count++] = p;
                }
            }
        }
    }
    return count;
}

/* The corners on plane f, as flags.  Returns how many. */
static int on_plane(const halves *h, int f, const spot *corner, int count, unsigned char *on)
{
    int m, sum = 0;
    for (m = 0; m < count; m++) {
        on[m] = half_at(h, f, corner + m) == 0;
        sum += on[m];
    }
    return sum;
}

/* The facet of a cell with the corners of plane f.  Of planes that coincide any may be named.  Returns first[i + 1]
   if there is none, PBW_NONE if an earlier plane has these corners, too. */
static size_t facet_of(const pbw_cells *cells, size_t i, const halves *h, int f, const spot *corner, int count)
{
    unsigned char on[2000], more[2000];
    size_t e, found = cells->first[i + 1];
    int g;
    (void)on_plane(h, f, corner, count, on);
    for (g = 0; g < h->count; g++) {
        (void)on_plane(h, g, corner, count, more);
        if (memcmp(on, more, (size_t)count) == 0) {
            if (g < f) {
                return PBW_NONE;
            }
            for (e = cells->first[i]; e < cells->first[i + 1]; e++) {
                found = cells->neighbors[e] == h->name[g] ? e : found;
            }
        }
    }
    return found;
}

/* Every facet of each cell, and the corners of its loop; span: do the points span the space? */
static void check_counts(const sites *s, const pbw_domain *domain, int span)
{
    spot *corner = (spot *)take(2000 * sizeof *corner);
    pbw_mesh mesh;
    pbw_cells cells;
    size_t i;
    CHECK_EQUAL(pbw_triangulate(s->dim, s->x, s->w, s->count, NULL, &mesh), span ? PBW_OK : PBW_DEGENERATE);
    CHECK_EQUAL(pbw_cells_of(&mesh, domain, ALL | PBW_CELLS_MERGE, NULL, &cells), PBW_OK);
    for (i = 0; i < cells.cell_count; i++) {
        const halves h = halves_of(s, &mesh, domain, i);
        const int count = corners_of(&h, corner, 2000);
        unsigned char on[2000];
        size_t facets = 0, e;
        int f, flat = count < 4;
        if (mesh.canonical[i] != i) {
            CHECK_EQUAL(cells.first[i + 1], cells.first[i]);
            continue;
        }
        for (f = 0; f < h.count; f++) {
            flat |= on_plane(&h, f, corner, count, on) == count;
        }
        for (f = 0; f < h.count && !flat; f++) {
            const int sum = on_plane(&h, f, corner, count, on);
            if (sum < (s->dim == 3 ? 3 : 4) || h.name[f] == PBW_NONE
                || (e = facet_of(&cells, i, &h, f, corner, count)) == PBW_NONE) {
                continue;
            }
            facets++;
            if (CHECK(e < cells.first[i + 1])) {
                CHECK_EQUAL(cells.loop_first[e + 1] - cells.loop_first[e], s->dim == 3 ? sum : 2);
            }
        }
        CHECK_EQUAL(cells.first[i + 1] - cells.first[i], facets);
    }
    pbw_cells_free(&cells);
    pbw_free(&mesh);
    free(corner);
}

/* All points with integer coordinates on a sphere or circle around (4, 4, 4). */
static sites sphere(int dim, int square)
{
    sites s;
    int x, y, z;
    memset(&s, 0, sizeof s);
    s.dim = dim;
    s.x = (double *)take(3000 * sizeof(double));
    for (x = -9; x <= 9; x++) {
        for (y = -9; y <= 9; y++) {
            for (z = dim == 3 ? -9 : 0; z <= (dim == 3 ? 9 : 0); z++) {
                double *p = s.x + s.count * (size_t)dim;
                if (x * x + y * y + z * z == square) {
                    p[dim - 1] = 4 + z;
                    p[0] = 4 + x;
                    p[1] = 4 + y;
                    s.count++;
                }
            }
        }
    }
    return s;
}

/* Points of a grid, some twice, with weights or without. */
static sites grid_sites(int dim, size_t count, int side, int weighted, uint64_t *state)
{
    sites s;
    size_t i;
    memset(&s, 0, sizeof s);
    s.dim = dim;
    s.count = count;
    s.x = (double *)take(count * 3 * sizeof(double));
    s.w = weighted ? (double *)take(count * sizeof(double)) : NULL;
    for (i = 0; i < count * (size_t)dim; i++) {
        s.x[i] = (double)(input_next(state) % (uint64_t)side) + (i % 7 == 0 ? 1 : 0);
    }
    for (i = 0; i < count && weighted; i++) {
        s.w[i] = (double)(input_next(state) % 4);
    }
    return s;
}

static void test_counts(void)
{
    static const double boxes[5][6] = { { 0, 0, 0, 8, 8, 8 }, { -9, -9, -9, 20, 20, 20 }, { 4, 4, 4, 9, 9, 9 },
                                        { 4, 1, -2, 12, 4, 7 }, { 1, 2, 3, 5, 6, 4 } };
    static const int squares[5] = { 9, 14, 25, 17, 26 };
    uint64_t state = test_seed;
    int k, b, dim;
    for (dim = 2; dim <= 3; dim++) {
        for (k = 0; k < (dim == 3 ? 3 : 5); k++) {
            if (test_begin("merged facets of cut cells: %dD sphere %d", dim, squares[k])) {
                sites s = sphere(dim, squares[k]);
                for (b = 0; b < 5 && s.count > 3; b += dim - 1) {
                    pbw_domain domain;
                    double box[6];
                    memset(&domain, 0, sizeof domain);
                    memcpy(box, boxes[b], sizeof box);
                    memcpy(box + dim, boxes[b] + 3, (size_t)dim * sizeof *box);
                    domain.box = box;
                    check_counts(&s, &domain, 1);
                }
                sites_free(&s);
                test_end();
            }
        }
        if (test_begin("merged facets of cut cells: %dD grids", dim)) {
            for (k = 0; k < 60; k++) {
                sites s = grid_sites(dim, 6 + (size_t)k / 3, 3 + k % 3, k % 2, &state);
                pbw_domain domain;
                double planes[32], box[6] = { 0, 0, 0, 0, 0, 0 };
                size_t p;
                memset(&domain, 0, sizeof domain);
                for (b = 0; b < dim; b++) {
                    box[b] = k / 4 % 3 - 1;
                    box[dim + b] = box[b] + 3;
                }
                domain.box = k % 3 != 0 ? box : NULL;
                if (k % 3 != 1) {
                    domain.planes = planes;
                    domain.plane_count = diamond(dim, planes);
                    for (p = 0; p < domain.plane_count; p++) {       /* around (1, 1, 1), of size 3 */
                        double *plane = planes + p * (size_t)(dim + 1);
                        plane[dim] = 3 + plane[0] + plane[1] + (dim == 3 ? plane[2] : 0);
                    }
                }
                check_counts(&s, &domain, 1);
                sites_free(&s);
            }
            test_end();
        }
    }
}

/* ---- points that span no simplex: one, two, on lines and in planes, some twice, with weights that hide some */

enum { FLATS = 10 };

/* Points with coordinates from 0 to 12. */
static sites flat_sites(int dim, int kind, int weighted)
{
    static const int step[FLATS][2][3] = {
        { { 0, 0, 0 }, { 0, 0, 0 } }, { { 3, 5, 2 }, { 0, 0, 0 } }, { { 1, 0, 0 }, { 0, 0, 0 } },
        { { 0, 2, 0 }, { 0, 0, 0 } }, { { 1, 1, 1 }, { 0, 0, 0 } }, { { 2, -1, 1 }, { 0, 0, 0 } },
        { { 1, 0, 0 }, { 0, 1, 0 } }, { { 0, 1, 0 }, { 0, 0, 2 } }, { { 1, -1, 0 }, { 0, 1, -1 } },
        { { 1, 1, 2 }, { 1, -1, 0 } } };
    const int count = kind < 2 ? kind + 1 : 6, rows = kind < 6 ? 1 : 3;
    sites s;
    int i, j, k;
    memset(&s, 0, sizeof s);
    s.dim = dim;
    s.x = (double *)take(60 * sizeof(double));
    s.w = weighted ? (double *)take(20 * sizeof(double)) : NULL;
    for (j = 0; j < rows; j++) {
        for (i = 0; i < count; i++) {
            for (k = 0; k < dim; k++) {
                const int at = (i < 5 ? i : 2) * step[kind][0][k] + j * step[kind][1][k];
                s.x[s.count * (size_t)dim + (size_t)k] = at + (k == 1 && (kind == 5 || kind > 7) ? 5 : 1);
            }
            if (weighted) {
                s.w[s.count] = (i * 5 + j * 3) % 7;
            }
            s.count++;
        }
    }
    return s;
}

/* Volumes in a domain add up to it; in a polygon, here s->box, they are those in that box. */
static void check_whole(const sites *s, const pbw_domain *domain, double whole)
{
    pbw_domain box;
    pbw_mesh mesh;
    pbw_cells cells, boxed;
    size_t i;
    memset(&box, 0, sizeof box);
    box.box = s->box;
    CHECK_EQUAL(pbw_triangulate(s->dim, s->x, s->w, s->count, NULL, &mesh), PBW_DEGENERATE);
    CHECK_EQUAL(pbw_cells_of(&mesh, domain, ALL, NULL, &cells), PBW_OK);
    CHECK_EQUAL(pbw_cells_of(&mesh, &box, 0, NULL, &boxed), PBW_OK);
    CHECK(fabs(sum_of(&cells) - whole) < 1e-12 * whole);
    for (i = 0; i < s->count && domain->ring_count > 0; i++) {
        CHECK(fabs(cells.volumes[i] - boxed.volumes[i]) < 1e-11 * whole);
    }
    pbw_cells_free(&cells);
    pbw_cells_free(&boxed);
    CHECK_EQUAL(pbw_cells_of(&mesh, NULL, ALL, NULL, &cells), PBW_DEGENERATE);
    CHECK(cells.cell_count == s->count && cells.facet_count == 0 && !(sum_of(&cells) > 0));
    pbw_cells_free(&cells);
    pbw_free(&mesh);
}

static void test_flats(void)
{
    static const double boxes[3][6] = { { 0, 0, 0, 14, 12, 13 }, { 2, -3, 1, 5, 30, 7 },
                                        { -1, -1, -9000, 14, 12, 13 } };         /* the last one: deep */
    int dim, kind, weighted, b;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < (dim == 2 ? 6 : FLATS); kind++) {
            for (weighted = 0; weighted < 2; weighted++) {
                if (test_begin("flat points: %dD kind %d%s", dim, kind, weighted ? ", weighted" : "")) {
                    for (b = 0; b < 3; b++) {
                        const size_t first[2] = { 0, 4 };
                        sites s = flat_sites(dim, kind, weighted);
                        pbw_domain domain;
                        double planes[32], ring[8];
                        size_t p;
                        memset(&domain, 0, sizeof domain);
                        memcpy(s.box, boxes[b], sizeof s.box);
                        memcpy(s.box + dim, boxes[b] + 3, (size_t)dim * sizeof *s.box);
                        domain.box = s.box;
                        check_counts(&s, &domain, 0);
                        if (b == 2) {
                            check_whole(&s, &domain, volume_of(dim, s.box));
                            sites_free(&s);
                            continue;
                        }
                        for (p = 0; p < s.count && weighted; p++) {  /* so that no two planes coincide */
                            s.w[p] += 0.37 * (double)(p % 4);
                        }
                        check_brute(&s, 0, 200);
                        domain.box = NULL;
                        domain.planes = planes;
                        domain.plane_count = diamond(dim, planes);
                        check_whole(&s, &domain, dim == 3 ? 4.0 / 3 : 2);
                        for (p = 0; p < 4; p++) {
                            ring[2 * p] = s.box[p == 1 || p == 2 ? dim : 0];
                            ring[2 * p + 1] = s.box[p > 1 ? dim + 1 : 1];
                        }
                        domain.planes = NULL;
                        domain.plane_count = 0;
                        domain.rings = ring;
                        domain.ring_first = first;
                        domain.ring_count = 1;
                        if (dim == 2) {
                            check_whole(&s, &domain, volume_of(2, s.box));
                        }
                        sites_free(&s);
                    }
                    test_end();
                }
            }
        }
    }
}

/* ---- the zoo: each input with a box around it */

static void test_zoo(void)
{
    zoo animals;
    size_t i;
    zoo_fill(&animals);
    for (i = 0; i < animals.count; i++) {
        const zoo_input *in = animals.items + i;
        sites s;
        memset(&s, 0, sizeof s);
        s.dim = in->dim, s.count = in->count, s.x = in->points, s.w = in->weights;
        if (in->finite && in->count <= 3000 && test_begin("zoo: %s", in->name)) {
            pbw_domain domain;
            pbw_mesh mesh;
            pbw_cells cells, plain;
            pbw_status status, expected;
            memset(&domain, 0, sizeof domain);
            bound(&s, 0.05, s.box);
            domain.box = s.box;
            expected = pbw_triangulate(s.dim, s.x, s.w, s.count, NULL, &mesh);
            status = pbw_cells_of(&mesh, &domain, ALL, NULL, &cells);
            CHECK(status == (s.count > 0 ? PBW_OK : expected)
                  || (status == PBW_ERROR_ARGUMENT && !(thinnest_of(&s) > 0 && extent_of(&s) < 1e300)));
            if (status == PBW_OK) {
                const double extent = extent_of(&s), sum = fabs(sum_of(&cells) / volume_of(s.dim, s.box) - 1);
                double largest = 0;
                size_t k;
                for (k = 0; k < s.count * (size_t)s.dim; k++) {
                    largest = fmax(largest, fabs(s.x[k]));
                }
                for (k = 0; k < s.count && s.w != NULL; k++) {
                    largest = fmax(largest, sqrt(fabs(s.w[k])));
                }
                if (extent < 1e90 && extent > 1e-90 && largest < 1e4 * thinnest_of(&s)
                    && !CHECK(sum < 1e-11)) {        /* else volumes over- or underflow, or cells are ulps */
                    test_say("volumes %g", sum);
                }
                CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &plain), PBW_OK);
                if (extent < 1e90 && extent > 1e-90 && largest < 1e4 * thinnest_of(&s)
                    && !CHECK(differ(&cells, &plain, s.box) < 1e-11)) {
                    test_say("volumes alone differ by %g", differ(&cells, &plain, s.box));
                }
                pbw_cells_free(&plain);
                CHECK_EQUAL(pbw_cells_of(&mesh, NULL, ALL | PBW_CELLS_MERGE, NULL, &plain), expected);
                pbw_cells_free(&plain);
            }
            pbw_cells_free(&cells);
            pbw_free(&mesh);
            test_end();
        }
    }
    zoo_free(&animals);
}

/* ---- periodic boxes */

/* The sum of volumes, Gauss, and each facet seen from the other side with the opposite shift.  Returns the worst. */
static double periodic_faults(const pbw_cells *cells, const double *box)
{
    const size_t dim = (size_t)cells->dim;
    const double unit = pow(volume_of(cells->dim, box), (cells->dim - 1.0) / cells->dim);
    double worst = 10 * fabs(sum_of(cells) / volume_of(cells->dim, box) - 1);
    size_t i, f, g, k;
    for (i = 0; i < cells->cell_count; i++) {
        for (f = cells->first[i]; f < cells->first[i + 1]; f++) {
            const pbw_index j = cells->neighbors[f];
            double back = 0;
            if (j >= cells->cell_count) {
                continue;                            /* a wall */
            }
            for (g = cells->first[j]; g < cells->first[j + 1]; g++) {
                int opposite = cells->neighbors[g] == i;
                for (k = 0; k < dim; k++) {
                    opposite &= cells->shifts[g * dim + k] == -cells->shifts[f * dim + k];
                }
                back += opposite ? cells->areas[g] : 0;
            }
            worst = fmax(worst, fabs(back - cells->areas[f]) / unit);
        }
    }
    return worst;
}

static void test_periodic(int dim, size_t count, int kind, int weights, unsigned axes)
{
    if (test_begin("periodic: %dD, %d %s, weights %s, axes %u", dim, (int)count, input_name(kind),
                   input_weights_name(weights), axes)) {
        sites s = sites_make(kind, dim, count, weights);
        pbw_options one = threads(1), four = threads(4);
        pbw_domain domain;
        pbw_cells cells, again;
        double worst;
        memset(&domain, 0, sizeof domain);
        domain.box = s.box;
        domain.periodic = axes;
        CHECK_EQUAL(pbw_cells_periodic(dim, s.x, s.w, count, &domain, ALL, &one, &cells), PBW_OK);
        CHECK_EQUAL(pbw_cells_periodic(dim, s.x, s.w, count, &domain, ALL, &four, &again), PBW_OK);
        CHECK(same_cells(&cells, &again));
        worst = cells.first != NULL ? periodic_faults(&cells, s.box) : 1;
        if (!CHECK(worst < 1e-11)) {
            test_say("%g", worst);
        }
        pbw_cells_free(&cells);
        pbw_cells_free(&again);
        sites_free(&s);
        test_end();
    }
}

/* Points all moved by one vector of multiples of the unit: the same neighbours and volumes. */
static void test_moved(int dim, int kind, size_t count)
{
    if (test_begin("periodic: %dD, %d %s, moved", dim, (int)count, input_name(kind))) {
        const double box[6] = { 0, 0, dim == 3 ? 0.0 : 8, 8, 8, 8 }, move[3] = { 2.375, -5.5, 1.0 / 1024 };
        const size_t size = (size_t)dim;
        sites s = sites_make(kind, dim, count, INPUT_WEIGHTS_ZERO);
        pbw_domain domain;
        pbw_cells a, b;
        size_t i, j, differ = 0;
        memset(&domain, 0, sizeof domain);
        domain.box = box;
        domain.periodic = dim == 3 ? 7 : 3;
        for (i = 0; i < count * size; i++) {
            s.x[i] = kind == INPUT_LATTICE ? s.x[i] : floor(s.x[i] * 8192) / 1024;
        }
        CHECK_EQUAL(pbw_cells_periodic(dim, s.x, NULL, count, &domain, PBW_CELLS_FACETS, NULL, &a), PBW_OK);
        for (i = 0; i < count * size; i++) {
            s.x[i] += move[i % size];
        }
        CHECK_EQUAL(pbw_cells_periodic(dim, s.x, NULL, count, &domain, PBW_CELLS_FACETS, NULL, &b), PBW_OK);
        CHECK_EQUAL(a.facet_count, b.facet_count);
        for (i = 0; i < count; i++) {
            CHECK(fabs(a.volumes[i] - b.volumes[i]) < 1e-12 * volume_of(dim, box));
            for (j = 0; j < count; j++) {
                differ += fabs(area_to(&a, i, (pbw_index)j) - area_to(&b, i, (pbw_index)j)) > 1e-11;
            }
            if (kind == INPUT_LATTICE) {             /* 8 per axis */
                CHECK(fabs(a.volumes[i] - 1) < 1e-13);
            }
        }
        CHECK_EQUAL(differ, 0);
        pbw_cells_free(&a);
        pbw_cells_free(&b);
        sites_free(&s);
        test_end();
    }
}

/* Points that crowd do not make the void around them take copies of most of them: some 16,000 bytes a point. */
static void test_crowded(void)
{
    if (test_begin("periodic: 3D, 10000 clusters, in bounded memory")) {
        sites s = sites_make(INPUT_CLUSTERS, 3, 10000, INPUT_WEIGHTS_ZERO);
        pbw_options options = threads(1);
        pbw_domain domain;
        pbw_cells cells;
        meter m;
        memset(&domain, 0, sizeof domain);
        domain.box = s.box;
        domain.periodic = 7;
        options.resize = meter_resize;
        options.resize_user = &m;
        meter_start(&m, 0, 0);
        CHECK_EQUAL(pbw_cells_periodic(3, s.x, NULL, s.count, &domain, 0, &options, &cells), PBW_OK);
        if (!CHECK(m.peak < 6000 * s.count)) {
            test_say("%g bytes a point", (double)m.peak / (double)s.count);
        }
        pbw_cells_free(&cells);
        sites_free(&s);
        test_end();
    }
}

/* How much nearer a corner of a cell is to an image of another point than to its own; of a box from 0, all of which
   repeats, the nearest image is so along each axis. */
static double corner_fault(const pbw_cells *cells, const double *w, const double *box)
{
    const size_t dim = (size_t)cells->dim;
    double worst = 0;
    size_t i, at, j, k;
    for (i = 0; i < cells->cell_count; i++) {
        for (at = cells->loop_first[cells->first[i]]; at < cells->loop_first[cells->first[i + 1]]; at++) {
            const double *x = cells->vertices + dim * cells->loops[at];
            double own = w != NULL ? -w[i] : 0, least = HUGE_VAL, d;
            for (k = 0; k < dim; k++) {
                own += (x[k] - cells->sites[dim * i + k]) * (x[k] - cells->sites[dim * i + k]);
            }
            for (j = 0; j < cells->cell_count; j++) {
                double power = w != NULL ? -w[j] : 0;
                for (k = 0; k < dim; k++) {
                    d = x[k] - cells->sites[dim * j + k];
                    d -= box[dim + k] * floor(d / box[dim + k] + 0.5);
                    power += d * d;
                }
                least = fmin(least, power);
            }
            worst = fmax(worst, (own - least) / own);
        }
    }
    return worst;
}

/* Points in a thin slab of a high box: balls in the void are many periods wide, and hold few copies.  Bytes bound the
   copies that are made. */
static void test_slab(int dim, size_t count, double height, int weighted)
{
    if (test_begin("periodic: %dD, %d points in 1/%g of a box, weights %d", dim, (int)count, height, weighted)) {
        const size_t d = (size_t)dim;
        sites s = sites_make(INPUT_UNIFORM, dim, count, weighted ? INPUT_WEIGHTS_HALF : INPUT_WEIGHTS_ZERO);
        double box[6] = { 0, 0, 0, 1, 1, 1 }, skew[9] = { 0 };
        pbw_options options = threads(1), four = threads(4);
        pbw_domain domain, lattice;
        pbw_cells cells, again;
        double differ = 0;
        size_t i;
        meter m;
        memset(&domain, 0, sizeof domain);
        memset(&lattice, 0, sizeof lattice);
        box[d] = 1;
        box[2 * d - 1] = height;
        for (i = 0; i < d; i++) {                    /* the same lattice as the box */
            skew[i * d + i] = i + 1 < d ? 1 : height;
            skew[i * d] += i > 0 ? 2 : 0;
        }
        for (i = 0; i < d * count; i++) {
            s.x[i] = fmod(fabs(s.x[i]), 1);
        }
        domain.box = box;
        domain.periodic = (1u << dim) - 1;
        lattice.lattice = skew;
        options.resize = meter_resize;
        options.resize_user = &m;
        meter_start(&m, 0, 0);
        CHECK_EQUAL(pbw_cells_periodic(dim, s.x, s.w, count, &domain, ALL, &options, &cells), PBW_OK);
        if (!CHECK(m.peak < 20000 * count + 2000000)) {
            test_say("%g bytes a point", (double)m.peak / (double)count);
        }
        if (!CHECK(cells.first != NULL && corner_fault(&cells, s.w, box) < 1e-9)
            || !CHECK(fabs(sum_of(&cells) / height - 1) < 1e-12)) {
            test_say("a corner %g nearer, volume %.17g", cells.first != NULL ? corner_fault(&cells, s.w, box) : 0,
                     sum_of(&cells));
        }
        CHECK_EQUAL(pbw_cells_periodic(dim, s.x, s.w, count, &domain, ALL, &four, &again), PBW_OK);
        CHECK(same_cells(&cells, &again));
        pbw_cells_free(&again);
        CHECK_EQUAL(pbw_cells_periodic(dim, s.x, s.w, count, &lattice, ALL, &four, &again), PBW_OK);
        for (i = 0; i < count && again.volumes != NULL && cells.volumes != NULL; i++) {
            differ = fmax(differ, fabs(again.volumes[i] - cells.volumes[i]));
        }
        if (!CHECK(differ < 1e-8 * height)) {        /* points of a lattice are rounded to 2^-45 of its height */
            test_say("volumes differ by %g", differ);
        }
        pbw_cells_free(&again);
        pbw_cells_free(&cells);
        sites_free(&s);
        test_end();
    }
}

/* ---- lattices of any vectors, against brute force: `base` are vectors of moderate angles, and the given ones are
   sums of them, sum[k][i] of each, which make the same lattice. */

typedef struct lattices { int dim; double base[3][3]; int sum[3][3]; double given[9], volume; } lattices;

static double random_of(uint64_t *state, double low, double high)
{
    return low + (high - low) * (double)(input_next(state) >> 11) / 9007199254740992.0;
}

/* skew: steps in which one given vector gets another one added or taken away */
static lattices lattices_make(int dim, int skew, uint64_t *state)
{
    lattices l;
    int i, k, m, step;
    memset(&l, 0, sizeof l);
    l.dim = dim;
    for (i = 0; i < dim; i++) {
        for (k = 0; k < dim; k++) {
            l.base[i][k] = random_of(state, -0.4, 0.4) + (i == k ? 1.5 : 0);
        }
        l.sum[i][i] = 1;
    }
    for (step = 0; step < skew; step++) {
        const int to = (int)input_below(state, (uint32_t)dim);
        const int from = (to + 1 + (int)input_below(state, (uint32_t)dim - 1)) % dim;
        const int sign = input_below(state, 2) != 0 ? 1 : -1;
        for (k = 0; k < dim; k++) {
            l.sum[to][k] += sign * l.sum[from][k];
        }
    }
    for (i = 0; i < dim; i++) {
        for (k = 0; k < dim; k++) {
            for (m = 0; m < dim; m++) {
                l.given[i * dim + k] += l.sum[i][m] * l.base[m][k];
            }
        }
    }
    l.volume = dim == 2 ? l.base[0][0] * l.base[1][1] - l.base[0][1] * l.base[1][0] : 0;
    for (k = 0; k < 3 && dim == 3; k++) {
        l.volume += l.base[0][k] * (l.base[1][(k + 1) % 3] * l.base[2][(k + 2) % 3]
                                    - l.base[1][(k + 2) % 3] * l.base[2][(k + 1) % 3]);
    }
    return l;
}

typedef struct image { double plane[4], far; pbw_index name; } image;

static int image_order(const void *a, const void *b)
{
    const double x = ((const image *)a)->far, y = ((const image *)b)->far;
    return x < y ? -1 : x > y;
}

static pbw_index image_name(size_t point, int a, int b, int c)
{
    return (pbw_index)((point * 9 + (size_t)(a + 4)) * 9 + (size_t)(b + 4)) * 9 + (pbw_index)(c + 4);
}

/* Half-spaces of the nearest images, 4 base vectors each way (in the plane in a slab of height 1). */
static void image_cell(const lattices *l, const pbw_cells *cells, const double *w, size_t i, brute *b)
{
    static image images[12 * 729];
    const size_t dim = (size_t)l->dim;
    const double *p = cells->sites + i * dim;
    int t[3], count = 0, f, c = dim == 3 ? 4 : 0;
    size_t j, k;
    for (j = 0; j < cells->cell_count; j++) {
        for (t[0] = -4; t[0] <= 4; t[0]++) {
            for (t[1] = -4; t[1] <= 4; t[1]++) {
                for (t[2] = -c; t[2] <= c; t[2]++) {
                    image *m = images + count;
                    double square = 0;
                    memset(m, 0, sizeof *m);
                    for (k = 0; k < dim; k++) {
                        m->plane[k] = cells->sites[j * dim + k] - p[k] + t[0] * l->base[0][k] + t[1] * l->base[1][k]
                                      + t[2] * l->base[2][k];
                        square += m->plane[k] * m->plane[k];
                    }
                    m->plane[3] = (square + (w != NULL ? w[i] - w[j] : 0)) / 2;
                    m->far = m->plane[3] / sqrt(square);
                    m->name = image_name(j, t[0], t[1], t[2]);
                    count += square > 0;
                }
            }
        }
    }
    qsort(images, (size_t)count, sizeof *images, image_order);
    b->count = 0;
    brute_add(b, 0, 0, -1, dim == 2 ? 0 : 100, PBW_NONE);
    brute_add(b, 0, 0, 1, dim == 2 ? 1 : 100, PBW_NONE);
    for (f = 0; b->count < BRUTE_PLANES; f++) {
        brute_add(b, images[f].plane[0], images[f].plane[1], images[f].plane[2], images[f].plane[3], images[f].name);
    }
}

static double image_area(const lattices *l, const pbw_cells *cells, size_t i, pbw_index name)
{
    const size_t dim = (size_t)l->dim;
    double area = 0;
    size_t f, k, m;
    for (f = cells->first[i]; f < cells->first[i + 1]; f++) {
        int t[3] = { 0, 0, 0 };
        for (k = 0; k < dim; k++) {
            for (m = 0; m < dim; m++) {
                t[m] += cells->shifts[f * dim + k] * l->sum[k][m];
            }
        }
        area += image_name(cells->neighbors[f], t[0], t[1], t[2]) == name ? cells->areas[f] : 0;
    }
    return area;
}

/* Each site is its point and whole given vectors. */
static double moved_fault(const lattices *l, const double *x, const double *site)
{
    double d[3] = { 0, 0, 0 }, worst = 0;
    int i, k;
    for (k = 0; k < l->dim; k++) {
        d[k] = site[k] - x[k];
    }
    for (i = 0; i < l->dim; i++) {                   /* along the i-th base vector: by Cramer's rule */
        double m[3][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }, det;
        for (k = 0; k < l->dim; k++) {
            memcpy(m[k], k == i ? d : l->base[k], (size_t)l->dim * sizeof(double));
        }
        det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
        worst = fmax(worst, fabs(det / l->volume - floor(det / l->volume + 0.5)));
    }
    return worst;
}

static void test_skew(int dim, size_t count, int skew, int weighted)
{
    if (test_begin("lattice: %dD, %d points, skew %d, weights %d", dim, (int)count, skew, weighted)) {
        uint64_t state = test_seed + (uint64_t)(skew * 100) + count;
        const lattices l = lattices_make(dim, skew, &state);
        pbw_domain domain;
        pbw_cells cells;
        double x[12 * 3], w[12] = { 0 }, fault = 0, areas = 0;
        size_t i;
        int f;
        memset(&domain, 0, sizeof domain);
        domain.lattice = l.given;
        for (i = 0; i < count * (size_t)dim; i++) {
            x[i] = random_of(&state, -3, 3);
        }
        for (i = 0; i < count; i++) {
            w[i] = random_of(&state, 0, 0.2);
        }
        CHECK_EQUAL(pbw_cells_periodic(dim, x, weighted ? w : NULL, count, &domain, ALL, NULL, &cells), PBW_OK);
        for (i = 0; i < count && cells.first != NULL; i++) {
            double volume = 0, cone;
            brute b;
            image_cell(&l, &cells, weighted ? w : NULL, i, &b);
            for (f = 0; f < b.count; f++) {
                const double area = brute_area(&b, f, 100, &cone);
                volume += cone;
                areas = b.name[f] == PBW_NONE ? areas
                      : fmax(areas, fabs(area - image_area(&l, &cells, i, b.name[f])));
            }
            fault = fmax(fault, fabs(volume - cells.volumes[i]));
            CHECK(moved_fault(&l, x + i * (size_t)dim, cells.sites + i * (size_t)dim) < 1e-9);
        }
        if (!CHECK(fault < 1e-10) || !CHECK(areas < 1e-10)) {
            test_say("volumes %g, areas %g", fault, areas);
        }
        CHECK(fabs(sum_of(&cells) / l.volume - 1) < 1e-12);
        pbw_cells_free(&cells);
        test_end();
    }
}

/* Crystals by their primitive vectors: all corners are exact, so that with PBW_CELLS_MERGE cells have the facets of
   the lattice's own cell. */
static void test_crystals(void)
{
    static const double cubic[4][9] = { { 0, 1, 1, 1, 0, 1, 1, 1, 0 }, { -1, 1, 1, 1, -1, 1, 1, 1, -1 },
                                        { 1, 0, 0, 5, 1, 0, -3, 8, 1 }, { 1, 0, 1, -1, 0, 0, 0, 0, 0 } };
    static const size_t facets[4] = { 12, 14, 6, 4 }, corners[4] = { 14, 24, 8, 4 };
    int i;
    for (i = 0; i < 4; i++) {
        if (test_begin("lattice: crystal %d", i)) {
            const int dim = i == 3 ? 2 : 3;
            const double x[3] = { 0.25, -7.5, 0.125 };
            pbw_domain domain;
            pbw_cells cells;
            size_t k, seen = 0;
            unsigned char *used;
            memset(&domain, 0, sizeof domain);
            domain.lattice = cubic[i];
            CHECK_EQUAL(pbw_cells_periodic(dim, x, NULL, 1, &domain, ALL | PBW_CELLS_MERGE, NULL, &cells), PBW_OK);
            CHECK_EQUAL(cells.facet_count, facets[i]);
            CHECK(fabs(cells.volumes[0] - (i == 0 ? 2 : i == 1 ? 4 : 1)) < 1e-13);
            used = (unsigned char *)take(cells.vertex_count);
            memset(used, 0, cells.vertex_count);
            for (k = 0; k < cells.loop_first[cells.facet_count]; k++) {
                seen += used[cells.loops[k]] == 0;
                used[cells.loops[k]] = 1;
            }
            CHECK_EQUAL(seen, corners[i]);
            free(used);
            pbw_cells_free(&cells);
            test_end();
        }
    }
}

static void test_same_lattice(int dim, int kind)
{
    if (test_begin("lattice: %dD %s as in a box", dim, input_name(kind))) {
        static const double skewed[9] = { 1, 0, 0, 3, 1, 0, -2, 4, 1 }, skewed2[4] = { 1, 0, 5, 1 };
        static const double unit[6] = { 0, 0, 0, 1, 1, 1 }, unit2[4] = { 0, 0, 1, 1 };
        const size_t count = 3000;
        sites s = sites_make(kind, dim, count, INPUT_WEIGHTS_ZERO);
        pbw_options one = threads(1), four = threads(4);
        pbw_domain box, domain;
        pbw_cells cells, same, again;
        size_t i;
        double worst = 0;
        memset(&box, 0, sizeof box);
        memset(&domain, 0, sizeof domain);
        for (i = 0; i < count * (size_t)dim; i++) {
            s.x[i] = floor(s.x[i] * 1e9) / 1073741824.0;     /* multiples of the units */
        }
        box.box = dim == 3 ? unit : unit2;
        box.periodic = (1u << dim) - 1;
        domain.lattice = dim == 3 ? skewed : skewed2;
        CHECK_EQUAL(pbw_cells_periodic(dim, s.x, NULL, count, &box, ALL, &one, &cells), PBW_OK);
        CHECK_EQUAL(pbw_cells_periodic(dim, s.x, NULL, count, &domain, ALL, &one, &same), PBW_OK);
        CHECK_EQUAL(pbw_cells_periodic(dim, s.x, NULL, count, &domain, ALL, &four, &again), PBW_OK);
        CHECK(same_cells(&same, &again));
        CHECK(memcmp(cells.first, same.first, (count + 1) * sizeof *cells.first) == 0);
        CHECK(memcmp(cells.sites, same.sites, count * (size_t)dim * sizeof *cells.sites) == 0);
        for (i = 0; i < count; i++) {
            worst = fmax(worst, fabs(cells.volumes[i] - same.volumes[i]));
            CHECK(fabs(cells.centroids[i * (size_t)dim] - same.centroids[i * (size_t)dim]) * cells.volumes[i]
                  < 1e-13);
        }
        CHECK(worst < 1e-13);
        pbw_cells_free(&cells);
        pbw_cells_free(&same);
        pbw_cells_free(&again);
        sites_free(&s);
        test_end();
    }
}

static void test_bad_lattices(void)
{
    if (test_begin("lattice: what is refused")) {
        const double flat[9] = { 1, 2, 3, 2, 4, 6, 0, 0, 1 }, nan = HUGE_VAL - HUGE_VAL, bad[4] = { 1, 0, nan, 1 };
        const double zero[9] = { 0 }, far_off[4] = { 1, 0, 1000, 1 }, good[4] = { 1, 0, 0, 1 };
        const double x[6] = { 0.5, 0.5, 0.25, 0.1, 0.2, 0.3 }, box[4] = { 0, 0, 1, 1 };
        pbw_domain domain;
        pbw_cells cells;
        memset(&domain, 0, sizeof domain);
        domain.lattice = flat;
        CHECK_EQUAL(pbw_cells_periodic(3, x, NULL, 2, &domain, ALL, NULL, &cells), PBW_ERROR_ARGUMENT);
        domain.lattice = zero;
        CHECK_EQUAL(pbw_cells_periodic(3, x, NULL, 2, &domain, ALL, NULL, &cells), PBW_ERROR_ARGUMENT);
        domain.lattice = bad;
        CHECK_EQUAL(pbw_cells_periodic(2, x, NULL, 2, &domain, ALL, NULL, &cells), PBW_ERROR_ARGUMENT);
        domain.lattice = far_off;                    /* a shift of 1000 */
        CHECK_EQUAL(pbw_cells_periodic(2, x, NULL, 2, &domain, ALL, NULL, &cells), PBW_ERROR_ARGUMENT);
        CHECK(cells.memory == NULL);
        CHECK_EQUAL(pbw_cells_periodic(2, x, NULL, 2, &domain, 0, NULL, &cells), PBW_OK);
        pbw_cells_free(&cells);
        domain.lattice = good;
        domain.box = box;
        CHECK_EQUAL(pbw_cells_periodic(2, x, NULL, 2, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        domain.box = NULL;
        CHECK_EQUAL(pbw_cells_of(NULL, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        test_end();
    }
}

static void test_skews(void)
{
    static const size_t counts[3] = { 1, 2, 7 };
    int dim, skew, c;
    for (dim = 2; dim <= 3; dim++) {
        for (skew = 0; skew <= 6; skew += 2) {
            for (c = 0; c < 3; c++) {
                test_skew(dim, counts[c], skew, 0);
                test_skew(dim, counts[c], skew, 1);
            }
        }
        test_same_lattice(dim, INPUT_UNIFORM);
        test_same_lattice(dim, INPUT_CLUSTERS);
    }
    test_crystals();
    test_bad_lattices();
}

static void test_periodics(void)
{
    static const size_t counts[7] = { 1, 2, 3, 10, 60, 500, TEST_SIZE(3000) };
    static const int weights[3] = { INPUT_WEIGHTS_ZERO, INPUT_WEIGHTS_HIDING, INPUT_WEIGHTS_HALF };
    unsigned axes;
    int dim, i, w;
    test_crowded();
    test_slab(3, TEST_SIZE(500), 100, 0);
    test_slab(3, 300, 1000, 1);
    test_slab(3, 60, 10000, 0);
    test_slab(2, TEST_SIZE(1000), 1000, 0);
    test_slab(2, 400, 5000, 1);
    for (dim = 2; dim <= 3; dim++) {
        for (i = 0; i < 7; i++) {
            for (axes = 1; axes < 1u << dim; axes++) {
                for (w = 0; w < 3; w++) {
                    test_periodic(dim, counts[i], INPUT_UNIFORM, weights[w], axes);
                }
            }
        }
        test_periodic(dim, TEST_SIZE(2000), INPUT_CLUSTERS, INPUT_WEIGHTS_ZERO, (1u << dim) - 1);
        test_periodic(dim, TEST_SIZE(2000), INPUT_CLUSTERS, INPUT_WEIGHTS_HIDING, 1);
        test_periodic(dim, TEST_SIZE(500), INPUT_LINES, INPUT_WEIGHTS_ZERO, (1u << dim) - 1);
        test_periodic(dim, 512, INPUT_LATTICE, INPUT_WEIGHTS_ZERO, (1u << dim) - 1);
        test_periodic(dim, TEST_SIZE(1000), INPUT_SPHERE, INPUT_WEIGHTS_ZERO, (1u << dim) - 1);
        test_moved(dim, INPUT_UNIFORM, 300);
        test_moved(dim, INPUT_UNIFORM, 600);
        test_moved(dim, INPUT_LATTICE, dim == 3 ? 512 : 64);
    }
}

/* ---- domains and unbounded cells */

static void test_domains(void)
{
    int dim, boxed;
    for (dim = 2; dim <= 3; dim++) {
        for (boxed = 0; boxed < 2; boxed++) {
            if (test_begin("planes: %dD, %s", dim, boxed ? "with a box" : "alone")) {
                const double box[6] = { 0, -2, dim == 3 ? -2.0 : 2, 2, 2, 2 };
                const double whole = dim == 3 ? 4.0 / 3 : 2;
                sites s = sites_make(INPUT_GAUSS, dim, 2000, INPUT_WEIGHTS_HIDING);
                double planes[32];
                pbw_domain domain;
                pbw_mesh mesh;
                pbw_cells cells;
                memset(&domain, 0, sizeof domain);
                domain.planes = planes;
                domain.plane_count = diamond(dim, planes);
                domain.box = boxed ? box : NULL;
                CHECK_EQUAL(pbw_triangulate(dim, s.x, s.w, s.count, NULL, &mesh), PBW_OK);
                CHECK_EQUAL(pbw_cells_of(&mesh, &domain, ALL, NULL, &cells), PBW_OK);
                CHECK(fabs(sum_of(&cells) / (boxed ? whole / 2 : whole) - 1) < 1e-12);
                CHECK(faults_of(&mesh, &domain, &cells, 2) < 1e-11);
                pbw_cells_free(&cells);
                pbw_free(&mesh);
                sites_free(&s);
                test_end();
            }
        }
    }
}

/* Loops of unbounded facets end in two rays, each perpendicular to the edge between the sites, and outward. */
static void test_rays(int dim)
{
    if (test_begin("rays: %dD", dim)) {
        sites s = sites_make(INPUT_UNIFORM, dim, 300, INPUT_WEIGHTS_ZERO);
        const size_t size = (size_t)dim;
        pbw_mesh mesh;
        pbw_cells cells;
        size_t i, j, f, l, k, open = 0;
        CHECK_EQUAL(pbw_triangulate(dim, s.x, NULL, s.count, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_cells_of(&mesh, NULL, ALL, NULL, &cells), PBW_OK);
        for (i = 0; i < s.count; i++) {
            int has_rays = 0;
            for (f = cells.first[i]; f < cells.first[i + 1]; f++) {
                size_t rays = 0;
                for (l = cells.loop_first[f]; l < cells.loop_first[f + 1]; l++) {
                    if (cells.loops[l] > PBW_NONE - 1 - cells.ray_count) {
                        const double *ray = cells.rays + (PBW_NONE - 1 - cells.loops[l]) * size;
                        double along = 0, length = 0;
                        for (k = 0; k < size; k++) {
                            const double to = mesh.points[cells.neighbors[f] * size + k];
                            along += ray[k] * (to - mesh.points[i * size + k]);
                            length += ray[k] * ray[k];
                        }
                        CHECK(fabs(along) < 1e-14 && fabs(length - 1) < 1e-14);
                        for (j = 0; j < s.count; j++) {
                            for (k = 0, along = 0; k < size; k++) {
                                along += ray[k] * (mesh.points[j * size + k] - mesh.points[i * size + k]);
                            }
                            CHECK(along < 1e-14);
                        }
                        rays++;
                    } else {
                        CHECK(cells.loops[l] < cells.vertex_count);
                    }
                }
                CHECK_EQUAL(rays, cells.areas[f] < HUGE_VAL ? 0 : dim - 1);
                has_rays |= rays > 0;
            }
            CHECK_EQUAL(has_rays, !(cells.volumes[i] < HUGE_VAL));
            open += (size_t)has_rays;
        }
        CHECK(open > (size_t)dim);
        pbw_cells_free(&cells);
        pbw_free(&mesh);
        sites_free(&s);
        test_end();
    }
}

static void test_arguments(void)
{
    if (test_begin("arguments")) {
        const double points[12] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1 }, nan = HUGE_VAL - HUGE_VAL;
        const double broken[3] = { 0, nan, 0 };
        const double empty[6] = { 1, 1, 1, 0, 0, 0 }, unit[6] = { -1, -1, -1, 2, 2, 2 };
        double planes[8] = { 1, 0, 0, 0, -1, 0, 0, -1 };
        pbw_domain domain;
        pbw_mesh mesh;
        pbw_cells cells;
        memset(&domain, 0, sizeof domain);
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, 4, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_cells_of(NULL, NULL, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_cells_of(&mesh, NULL, 0, NULL, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_cells_of(&mesh, NULL, 8, NULL, &cells), PBW_ERROR_ARGUMENT);
        domain.box = empty;
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        domain.box = NULL;
        domain.plane_count = 1;
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        domain.planes = planes;
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);      /* unbounded */
        domain.box = unit;
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_OK);
        CHECK(fabs(sum_of(&cells) - 9) < 1e-12);
        pbw_cells_free(&cells);
        domain.plane_count = 2;                                                             /* x <= 0 and x >= 1 */
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        planes[1] = nan;
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        CHECK(cells.memory == NULL && cells.cell_count == 0);
        domain.plane_count = 0;
        CHECK_EQUAL(pbw_cells_periodic(3, points, NULL, 4, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        domain.periodic = 7;
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_cells_periodic(3, broken, NULL, 1, &domain, 0, NULL, &cells), PBW_ERROR_NOT_FINITE);
        pbw_free(&mesh);
        test_end();
    }
}

/* ---- threads, failures */

static int stop(void *user, pbw_stage stage, double done)
{
    (void)done;
    return stage == PBW_STAGE_WORK && --*(int *)user < 0;
}

/* Cells of a mesh, or (mesh NULL) periodic ones. */
static pbw_status compute(const sites *s, const pbw_mesh *mesh, const pbw_options *options, pbw_cells *cells)
{
    pbw_domain domain;
    memset(&domain, 0, sizeof domain);
    domain.box = s->box;
    domain.periodic = mesh != NULL ? 0 : 1;
    return mesh != NULL ? pbw_cells_of(mesh, &domain, ALL | PBW_CELLS_MERGE, options, cells)
                        : pbw_cells_periodic(s->dim, s->x, s->w, s->count, &domain, ALL, options, cells);
}

static void test_threads(int dim, int kind, int weights)
{
    if (test_begin("threads: %dD %s, weights %s", dim, input_name(kind), input_weights_name(weights))) {
        sites s = sites_make(kind, dim, TEST_SIZE(10000), weights);
        static const int counts[3] = { 1, 4, 8 };
        pbw_mesh mesh;
        pbw_cells cells[3];
        int i;
        CHECK_EQUAL(pbw_triangulate(dim, s.x, s.w, s.count, NULL, &mesh), PBW_OK);
        for (i = 0; i < 3; i++) {
            pbw_options options = threads(counts[i]);
            CHECK_EQUAL(compute(&s, &mesh, &options, cells + i), PBW_OK);
        }
        CHECK(same_cells(cells, cells + 1));
        CHECK(same_cells(cells, cells + 2));
        CHECK(fabs(sum_of(cells) / volume_of(dim, s.box) - 1) < 1e-12);
        for (i = 0; i < 3; i++) {
            pbw_cells_free(cells + i);
        }
        pbw_free(&mesh);
        sites_free(&s);
        test_end();
    }
}

static void test_failures(int dim, int periodic, int flat)
{
    if (test_begin("failures: %dD%s%s", dim, periodic ? ", periodic" : "", flat ? ", flat" : "")) {
        sites s = sites_make(INPUT_UNIFORM, dim, 60, INPUT_WEIGHTS_ZERO);
        pbw_options options = threads(1);
        pbw_mesh mesh;
        pbw_cells cells;
        meter m;
        long k;
        int left = 0;
        size_t i;
        pbw_status status = PBW_ERROR_MEMORY;
        for (i = 0; i < s.count && flat; i++) {
            s.x[(i + 1) * (size_t)dim - 1] = 0.5;
        }
        CHECK_EQUAL(pbw_triangulate(dim, s.x, NULL, s.count, NULL, &mesh), flat ? PBW_DEGENERATE : PBW_OK);
        options.resize = meter_resize;
        options.resize_user = &m;
        for (k = 1; status == PBW_ERROR_MEMORY && k < 100000; k++) {
            meter_start(&m, k, k % 2 != 0);
            status = compute(&s, periodic ? NULL : &mesh, &options, &cells);
            CHECK(status == PBW_OK || cells.memory == NULL);
            pbw_cells_free(&cells);
            CHECK(m.blocks == 0 && m.bytes == 0 && m.faults == 0);
        }
        CHECK_EQUAL(status, PBW_OK);
        CHECK(k > 20);
        meter_start(&m, 0, 0);
        options.memory_limit = 1000;
        CHECK_EQUAL(compute(&s, periodic ? NULL : &mesh, &options, &cells), PBW_ERROR_MEMORY);
        CHECK(m.blocks == 0 && m.peak <= 1000);
        options.memory_limit = 0;
        options.progress = stop;
        options.progress_user = &left;
        for (k = 0, status = PBW_CANCELLED; status == PBW_CANCELLED && k < 1000; k++) {
            left = (int)k;
            status = compute(&s, periodic ? NULL : &mesh, &options, &cells);
            CHECK(status == PBW_OK || (status == PBW_CANCELLED && cells.memory == NULL));
            pbw_cells_free(&cells);
            CHECK(m.blocks == 0);
        }
        CHECK(status == PBW_OK && k > 3);
        pbw_free(&mesh);
        sites_free(&s);
        test_end();
    }
}

/* ---- limits of memory */

typedef struct limited { sites s; pbw_mesh mesh; pbw_domain domain; unsigned what; } limited;

static pbw_status limited_cells(const limited *l, const pbw_options *options, pbw_cells *cells)
{
    return l->domain.periodic != 0 || l->domain.lattice != NULL
         ? pbw_cells_periodic(l->s.dim, l->s.x, l->s.w, l->s.count, &l->domain, l->what, options, cells)
         : pbw_cells_of(&l->mesh, &l->domain, l->what, options, cells);
}

static pbw_status limited_rings(const limited *l, const pbw_options *options, pbw_cells *cells)
{
    pbw_rings found;
    memset(cells, 0, sizeof *cells);
    return pbw_cells_rings(&l->domain, options, &found);
}

/* At 30 levels of options.memory_limit a call holds at most that, and gives the same cells or PBW_ERROR_MEMORY. */
static void check_levels(const char *name, const limited *l, int threads_,
                         pbw_status (*call)(const limited *l, const pbw_options *options, pbw_cells *cells))
{
    if (test_begin("memory limit: %dD %s, %d thread%s", l->s.dim, name, threads_, threads_ > 1 ? "s" : "")) {
        pbw_options options = threads(threads_);
        pbw_cells cells, other;
        meter m;
        size_t most, k, failed = 0;
        meter_start(&m, 0, 0);
        options.resize = meter_resize;
        options.resize_user = &m;
        CHECK_EQUAL(call(l, &options, &cells), PBW_OK);
        most = m.peak;
        pbw_cells_free(&cells);
        CHECK(m.blocks == 0);
        options.resize = NULL;
        options.resize_user = NULL;
        CHECK_EQUAL(call(l, &options, &cells), PBW_OK);
        options.resize = meter_resize;
        options.resize_user = &m;
        for (k = 1; k <= 30; k++) {                  /* to 1.5 times what it holds without a limit */
            pbw_status status;
            options.memory_limit = most * k / 20;
            meter_start(&m, 0, 0);
            status = call(l, &options, &other);
            CHECK(status != PBW_OK ? status == PBW_ERROR_MEMORY
                  : cells.memory == NULL
                    || (cells.first != NULL ? same_cells(&cells, &other) : same_volumes(&cells, &other)));
            pbw_cells_free(&other);
            CHECK(m.peak <= options.memory_limit && m.blocks == 0 && m.faults == 0);
            failed += status != PBW_OK;
        }
        test_say("holds %lu bytes; %lu of 30 limits suffice", (unsigned long)most, (unsigned long)(30 - failed));
        CHECK(failed >= 15 && failed < 30);
        pbw_cells_free(&cells);
        test_end();
    }
}

static void test_limits(int dim)
{
    static const double ring[10] = { 0.1, 0.1, 0.9, 0.2, 0.5, 0.5, 0.8, 0.9, 0.1, 0.8 };
    static const size_t ring_first[2] = { 0, 5 };
    const double skewed[9] = { 1, dim == 3 ? 0 : 0.2, dim == 3 ? 0 : 2, 1, 1, 0.3, 0.2, 0.1, 0.9 };
    const size_t count = 400;
    limited l;
    size_t i;
    memset(&l, 0, sizeof l);
    l.s = sites_make(INPUT_UNIFORM, dim, count, INPUT_WEIGHTS_HALF);
    CHECK_EQUAL(pbw_triangulate(dim, l.s.x, l.s.w, count, NULL, &l.mesh), PBW_OK);
    l.domain.box = l.s.box;
    l.what = ALL | PBW_CELLS_MERGE;
    check_levels("shapes", &l, 1, limited_cells);
    check_levels("shapes", &l, 3, limited_cells);
    l.what = 0;
    check_levels("volumes", &l, 1, limited_cells);
    l.domain.periodic = (1u << dim) - 1;
    check_levels("periodic, volumes", &l, 1, limited_cells);
    l.what = ALL;
    check_levels("periodic", &l, 1, limited_cells);
    l.domain.periodic = 1;
    check_levels("periodic along one axis", &l, 3, limited_cells);
    l.domain.periodic = 0;
    l.domain.box = NULL;
    l.domain.lattice = skewed;
    check_levels("lattice", &l, 1, limited_cells);
    l.domain.lattice = NULL;
    l.domain.box = l.s.box;
    if (dim == 2) {
        l.domain.box = NULL;
        l.domain.rings = ring;
        l.domain.ring_first = ring_first;
        l.domain.ring_count = 1;
        check_levels("polygon", &l, 1, limited_cells);
        check_levels("rings", &l, 1, limited_rings);
        l.domain.ring_count = 0;
        l.domain.box = l.s.box;
    }
    pbw_free(&l.mesh);
    for (i = 0; i < count; i++) {
        l.s.x[(i + 1) * (size_t)dim - 1] = 0.5;
    }
    CHECK_EQUAL(pbw_triangulate(dim, l.s.x, l.s.w, count, NULL, &l.mesh), PBW_DEGENERATE);
    check_levels("flat", &l, 1, limited_cells);
    pbw_free(&l.mesh);
    sites_free(&l.s);
}

static void test_degenerate(void)
{
    if (test_begin("degenerate, and hidden points")) {
        const double line[9] = { 0, 0, 0, 1, 1, 1, 2, 2, 2 }, box[6] = { -1, -1, -1, 3, 3, 3 };
        sites s = sites_make(INPUT_UNIFORM, 3, 1000, INPUT_WEIGHTS_HALF);
        pbw_domain domain;
        pbw_mesh mesh;
        pbw_cells cells;
        size_t i, hidden = 0;
        memset(&domain, 0, sizeof domain);
        domain.box = box;
        CHECK_EQUAL(pbw_triangulate(3, line, NULL, 3, NULL, &mesh), PBW_DEGENERATE);
        CHECK_EQUAL(pbw_cells_of(&mesh, NULL, ALL | PBW_CELLS_MERGE, NULL, &cells), PBW_DEGENERATE);
        CHECK(cells.cell_count == 3 && cells.facet_count == 0 && !(sum_of(&cells) > 0));
        pbw_cells_free(&cells);
        pbw_cells_free(&cells);
        pbw_free(&mesh);
        CHECK_EQUAL(pbw_triangulate(3, s.x, s.w, s.count, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, PBW_CELLS_FACETS, NULL, &cells), PBW_OK);
        for (i = 0; i < s.count; i++) {
            if (mesh.incident[i] == PBW_NONE) {
                CHECK(!(cells.volumes[i] > 0) && cells.first[i] == cells.first[i + 1]);
                hidden++;
            }
        }
        CHECK_EQUAL(hidden, mesh.hidden_count);
        CHECK(hidden > 100);
        pbw_cells_free(&cells);
        pbw_free(&mesh);
        sites_free(&s);
        test_end();
    }
}

static void test_rest(void)
{
    int dim, periodic;
    test_domains();
    test_arguments();
    test_degenerate();
    for (dim = 2; dim <= 3; dim++) {
        test_rays(dim);
        test_limits(dim);
        test_threads(dim, INPUT_UNIFORM, INPUT_WEIGHTS_ZERO);
        test_threads(dim, INPUT_LATTICE, INPUT_WEIGHTS_ZERO);
        test_threads(dim, INPUT_CLUSTERS, INPUT_WEIGHTS_HALF);
        for (periodic = 0; periodic < 2; periodic++) {
            test_failures(dim, periodic, 0);
        }
        test_failures(dim, 0, 1);
    }
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 0);
    test_kinds();
    test_facet_order();
    test_brutes();
    test_lattices();
    test_counts();
    test_flats();
    test_zoo();
    test_periodics();
    test_skews();
    test_rest();
    return test_finish();
}
