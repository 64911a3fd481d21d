/* fuzz_cells.c: cells of small inputs decoded from bytes, in boxes, half-spaces, polygons and periodic boxes: their
   volumes add up to the domain, areas times normals to zero, and the cells of two parts of a domain, which are cut,
   to those of the whole, which are read off the stars.
       make fuzz-cells      a million random inputs
       cc -O2 -DFUZZ_MAIN tests/fuzz_cells.c -o fuzz -lm -lpthread && ./fuzz --count 100000 --seed 1 */
#define PBW_IMPLEMENTATION
#include "../pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "../examples/lib/pbw_cells.h"
#if defined(__clang__)                                 /* coverage of the library is to guide the fuzzer, not ours */
#pragma clang attribute push(__attribute__((no_sanitize("coverage"))), apply_to = function)
#endif
#include "small.h"
#include "fuzz.h"
#if defined(__clang__)
#pragma clang attribute pop
#endif

#define CLOSE 1e-9

typedef struct fuzz_case {
    small_input in;
    double low[3], high[3], volume, size;  /* a box with a margin that may be negative; size: of its longest edge */
    int in_range;                          /* may volumes be compared?  Else all must only come to an end */
    unsigned choice;
} fuzz_case;

static void fuzz_decode(fuzz_case *c, const unsigned char *data, size_t size)
{
    static const double margins[4] = { 0.5, 0, -0.25, 3 };
    small_input *in = &c->in;
    double margin, most = 0, longest = 0, shortest = HUGE_VAL;
    int i, k;
    small_decode(in, data + (size > 0), size - (size > 0));
    c->choice = size > 0 ? data[0] : 0;
    margin = margins[c->choice % 4];
    c->volume = 1;
    for (k = 0; k < in->dim; k++) {
        double low = 0, high = 1, extent;
        for (i = 0; i < in->count; i++) {
            const double x = in->points[i * in->dim + k];
            low = i == 0 || x < low ? x : low;
            high = i == 0 || x > high ? x : high;
            most = fmax(most, fabs(x));
        }
        extent = high > low ? high - low : fmax(1, 0.5 * fabs(low));
        c->low[k] = low - margin * extent - (high > low ? 0 : extent);
        c->high[k] = high + margin * extent + (high > low ? 0 : extent);
        c->volume *= c->high[k] - c->low[k];
        longest = fmax(longest, c->high[k] - c->low[k]);
        shortest = fmin(shortest, c->high[k] - c->low[k]);
    }
    c->in_range = 1;
    for (i = 0; i < in->count * in->dim; i++) {      /* what polygons take */
        const double x = fabs(in->points[i]), w = fabs(in->weights[i / in->dim]);
        c->in_range = c->in_range && !(x > 0 && x < 1e-50) && !(w > 0 && w < 1e-100) && w <= 100 * longest * longest;
    }
    c->size = longest;
    c->in_range = c->in_range && most < 1e4 * longest && longest < 1e3 * shortest && longest > 1e-30
               && longest < 1e30;
}

static double fuzz_sum(const pbw_cells *cells)
{
    double sum = 0;
    size_t i;
    for (i = 0; i < cells->cell_count; i++) {
        sum += cells->volumes[i];
    }
    return sum;
}

/* Volumes that are not negative and add up to the domain. */
static const char *fuzz_whole(const fuzz_case *c, const pbw_cells *cells, double volume)
{
    size_t i;
    if (!c->in_range) {
        return NULL;
    }
    for (i = 0; i < cells->cell_count; i++) {
        if (!(cells->volumes[i] >= 0)) {
            return "a negative volume";
        }
    }
    return fabs(fuzz_sum(cells) - volume) <= CLOSE * c->volume ? NULL : "volumes that do not add up";
}

/* Areas times normals of a cell in the box add up to zero.  Not in question: cells so thin that cuts of their corners
   are at random. */
static const char *fuzz_closed(const fuzz_case *c, const pbw_mesh *mesh, const pbw_cells *cells)
{
    const size_t dim = (size_t)mesh->dim;
    size_t i, f, k;
    for (i = 0; c->in_range && i < cells->cell_count; i++) {
        double sum[3] = { 0, 0, 0 };
        for (f = cells->first[i]; f < cells->first[i + 1]; f++) {
            const pbw_index j = cells->neighbors[f], wall = PBW_NONE - 1 - j;
            double n[3] = { 0, 0, 0 }, square = 0;
            if (j < mesh->point_count) {
                for (k = 0; k < dim; k++) {
                    n[k] = mesh->points[j * dim + k] - mesh->points[i * dim + k];
                    square += n[k] * n[k];
                }
            } else {
                n[wall / 2] = wall % 2 != 0 ? 1 : -1;
                square = 1;
            }
            for (k = 0; k < dim; k++) {
                sum[k] += cells->areas[f] * n[k] / sqrt(square);
            }
        }
        for (k = 0; k < dim; k++) {
            if (cells->volumes[i] > 1e-12 * c->volume && !(fabs(sum[k]) <= 1e-7 * (dim == 3 ? c->size * c->size : c->size))) {
                return "areas that do not close";
            }
        }
    }
    return NULL;
}

/* Cells of a domain; sum: their volumes, with a sign, are added per cell.  Returns NULL or what is wrong. */
static const char *fuzz_part(const fuzz_case *c, const pbw_mesh *mesh, const pbw_domain *domain, double volume,
                             double sign, double *sum)
{
    pbw_options options;
    pbw_cells cells;
    const char *fault;
    size_t i;
    memset(&options, 0, sizeof options);
    options.threads = 1;
    if (pbw_cells_of(mesh, domain, c->choice & 64 ? 0 : PBW_CELLS_SHAPES, &options, &cells) != PBW_OK) {
        return "a status";
    }
    fault = fuzz_whole(c, &cells, volume);
    if (fault == NULL && domain->box != NULL && domain->plane_count == 0 && cells.first != NULL) {
        fault = fuzz_closed(c, mesh, &cells);
    }
    for (i = 0; i < cells.cell_count; i++) {
        sum[i] += sign * cells.volumes[i];
    }
    pbw_cells_free(&cells);
    return fault;
}

/* A box, and its two parts on both sides of a plane: by boxes, by half-spaces or by polygons. */
static const char *fuzz_parts(const fuzz_case *c, const pbw_mesh *mesh, unsigned how)
{
    static const size_t first[2] = { 0, 4 };
    const size_t dim = (size_t)mesh->dim;
    const double t = how % 2 != 0 ? 0.5 : 0.3125, x = c->low[0] + t * (c->high[0] - c->low[0]);
    double box[6], plane[4] = { 0, 0, 0, 0 }, ring[8], sum[SMALL_POINTS];
    const char *fault;
    pbw_domain domain;
    size_t i;
    int part;
    memset(sum, 0, sizeof sum);
    memset(&domain, 0, sizeof domain);
    memcpy(box, c->low, dim * sizeof(double));
    memcpy(box + dim, c->high, dim * sizeof(double));
    domain.box = box;
    fault = fuzz_part(c, mesh, &domain, c->volume, -1, sum);
    for (part = 0; part < 2 && fault == NULL; part++) {
        memset(&domain, 0, sizeof domain);
        if (how / 2 % 3 == 1) {
            plane[0] = part == 0 ? 1 : -1;
            plane[dim] = part == 0 ? x : -x;
            domain.planes = plane;
            domain.plane_count = 1;
        } else {
            box[0] = part == 0 ? c->low[0] : x;
            box[dim] = part == 0 ? x : c->high[0];
        }
        domain.box = box;
        if (how / 2 % 3 == 2 && dim == 2) {
            ring[0] = ring[6] = box[0];
            ring[1] = ring[3] = box[1];
            ring[2] = ring[4] = box[2];
            ring[5] = ring[7] = box[3];
            domain.rings = ring;
            domain.ring_first = first;
            domain.ring_count = 1;
            domain.box = NULL;
        }
        fault = fuzz_part(c, mesh, &domain, c->volume * (part == 0 ? t : 1 - t), 1, sum);
    }
    for (i = 0; i < mesh->point_count && c->in_range && fault == NULL; i++) {
        fault = fabs(sum[i]) <= CLOSE * c->volume ? NULL : "parts that are not the whole";
    }
    return fault;
}

/* The true diagram has the same volumes; without a domain bounded cells, too. */
static const char *fuzz_merged(const fuzz_case *c, const pbw_mesh *mesh)
{
    pbw_cells cells, merged;
    const size_t bytes = mesh->point_count * sizeof(double);
    const char *fault = NULL;
    (void)c;
    if (pbw_cells_of(mesh, NULL, PBW_CELLS_SHAPES, NULL, &cells) != PBW_OK) {
        return "a status without a domain";
    }
    if (pbw_cells_of(mesh, NULL, PBW_CELLS_SHAPES | PBW_CELLS_MERGE, NULL, &merged) != PBW_OK) {
        fault = "a status of the true diagram";
    } else if (memcmp(cells.volumes, merged.volumes, bytes) != 0 || merged.facet_count > cells.facet_count) {
        fault = "another true diagram";
    }
    pbw_cells_free(&cells);
    pbw_cells_free(&merged);
    return fault;
}

static const char *fuzz_periodic(const fuzz_case *c)
{
    double box[6];
    pbw_domain domain;
    pbw_cells cells;
    pbw_status status;
    const char *fault = NULL;
    memset(&domain, 0, sizeof domain);
    memcpy(box, c->low, (size_t)c->in.dim * sizeof(double));
    memcpy(box + c->in.dim, c->high, (size_t)c->in.dim * sizeof(double));
    domain.box = box;
    domain.periodic = (1u << c->in.dim) - 1;
    status = pbw_cells_periodic(c->in.dim, c->in.points, small_weights(&c->in), (size_t)c->in.count, &domain,
                                PBW_CELLS_FACETS, NULL, &cells);
    if (status == PBW_OK) {
        fault = c->in.count > 0 ? fuzz_whole(c, &cells, c->volume) : NULL;
    } else if (c->in_range) {
        fault = "a status of a periodic box";
    }
    pbw_cells_free(&cells);
    return fault;
}

static const char *fuzz(const unsigned char *data, size_t size, int print)
{
    static fuzz_case c;
    pbw_options options;
    pbw_mesh mesh;
    const char *fault = NULL;
    memset(&options, 0, sizeof options);
    options.threads = 1;
    fuzz_decode(&c, data, size);
    if (pbw_triangulate(c.in.dim, c.in.points, small_weights(&c.in), (size_t)c.in.count, &options, &mesh) == PBW_OK
        && c.in_range) {
        fault = fuzz_parts(&c, &mesh, c.choice / 8);
        fault = fault == NULL ? fuzz_merged(&c, &mesh) : fault;
    }
    if (fault == NULL && c.choice % 16 == 3 && c.in_range) {
        fault = fuzz_periodic(&c);
    }
    pbw_free(&mesh);
    if (print) {
        printf("choice %u, in_range %d, box %g %g %g to %g %g %g\n", c.choice, c.in_range, c.low[0], c.low[1],
               c.low[2], c.high[0], c.high[1], c.high[2]);
        small_print(&c.in);
    }
    return fault;
}
