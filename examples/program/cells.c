/* cells.c: pbw cells. */
#include "program.h"

static const option cells_options[] = {
    { "--box", "X,Y[,Z],X,Y[,Z]", "low corner and high corner: cells end there", BOX, 0, 0, NULL },
    { "--periodic", "xyz", "the axes along which the box repeats", AXES, 0, 0, NULL },
    { "--merge", NULL, "the true diagram: centres that coincide are one corner, facets without area left out", SWITCH,
      0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

static void emit(void *user, FILE *file)
{
    const pbw_cells *cells = (const pbw_cells *)user;
    const size_t dim = (size_t)cells->dim;
    size_t i, k;
    fprintf(file, "id,volume,x,y,%sfacets\n", dim == 3 ? "z," : "");
    for (i = 0; i < cells->cell_count; i++) {
        fprintf(file, "%zu,%.17g", i, cells->volumes[i]);
        for (k = 0; k < dim; k++) {
            fprintf(file, ",%.17g", cells->centroids[dim * i + k]);
        }
        fprintf(file, ",%zu\n", cells->first[i + 1] - cells->first[i]);
    }
}

static pbwio_status write_cells(job *j, const char *path, const char *ending, void *user, pbwio_error *error)
{
    const pbw_cells *cells = (const pbw_cells *)user;
    (void)j;
    return strcmp(ending, "csv") == 0 ? pbwio_save(path, emit, user, error)
         : write_diagram(path, ending, cells, error);
}

/* The sum has an error of one rounding (Neumaier 1974), so that it shows that of the cells. */
static void report(const job *j, const pbw_cells *cells, const double *box)
{
    const char *volume = cells->dim == 3 ? "volume" : "area";
    double sum = 0, rest = 0, whole = 1;
    size_t i, empty = 0, unbounded = 0;
    int k;
    for (i = 0; i < cells->cell_count; i++) {
        const double v = cells->volumes[i];
        if (v <= DBL_MAX) {
            const double next = sum + v;
            rest += sum >= v ? sum - next + v : v - next + sum;
            sum = next;
        }
        empty += v <= 0;
        unbounded += v > DBL_MAX;
    }
    note(j, "%zu cell%s, %zu of them empty, %zu unbounded; %zu facet%s", cells->cell_count, plural(cells->cell_count),
         empty, unbounded, cells->facet_count, plural(cells->facet_count));
    if (box == NULL) {
        note(j, "%s %.15g, the sum of bounded cells", volume, sum + rest);
        return;
    }
    for (k = 0; k < cells->dim; k++) {
        whole *= box[cells->dim + k] - box[k];
    }
    note(j, "%s %.15g, the sum of cells; %.15g, the box; relative difference %.1e", volume, sum + rest, whole,
         fabs(sum - whole + rest) / whole);
}

/* Bit k: axis k. */
static unsigned axes_of(const job *j)
{
    const char *letter = text_of(j, "--periodic");
    unsigned axes = 0;
    for (; letter != NULL && *letter != 0; letter++) {
        axes |= 1u << (*letter - 'x');
    }
    return axes;
}

static int make(job *j, const pbw_domain *domain, unsigned what, pbw_cells *cells)
{
    const pbwio_cloud *c = &j->cloud;
    pbw_status status;
    double start;
    int failed = 0;
    if (domain->periodic == 0) {
        failed = build(j);
        if (!failed) {
            describe(j);
        }
    }
    start = now();
    if (failed) {
        return failed;
    }
    status = domain->periodic == 0 ? pbw_cells_of(&j->mesh, domain, what, &j->build, cells)
           : pbw_cells_periodic(c->dim, c->points, c->weights, c->count, domain, what, &j->build, cells);
    failed = explain(j, status);
    if (!failed) {
        say(j, "cells", now() - start, "%s", "");
    }
    return failed;
}

static int run(job *j)
{
    pbw_domain domain;
    pbw_cells cells;
    double box[6];
    unsigned what = PBW_CELLS_FACETS;
    int i, failed;
    memset(&domain, 0, sizeof domain);
    memset(&cells, 0, sizeof cells);
    domain.periodic = axes_of(j);
    if (domain.periodic != 0 && !is_given(j, "--box")) {
        return complain("--periodic %s: it needs --box", text_of(j, "--periodic"));
    }
    failed = load(j, 1);
    if (failed) {
        return failed;
    }
    if (is_given(j, "--box") && !vector_of(j, "--box", 2 * j->cloud.dim, box)) {
        return fail(j, "--box %s: %d numbers are needed for points in %dD", text_of(j, "--box"), 2 * j->cloud.dim,
                    j->cloud.dim);
    }
    if (domain.periodic >> j->cloud.dim != 0) {
        return fail(j, "--periodic %s: the points are in 2D", text_of(j, "--periodic"));
    }
    domain.box = is_given(j, "--box") ? box : NULL;
    for (i = 0; i < j->outputs; i++) {
        const char *ending = ending_of(j, j->output[i]);
        what |= strcmp(ending, "csv") != 0 ? PBW_CELLS_SHAPES : 0;
        if (strcmp(ending, "svg") == 0 && j->cloud.dim == 3) {
            return fail(j, "%s: a picture of cells needs points in 2D", j->output[i]);
        }
    }
    failed = make(j, &domain, what | (is_given(j, "--merge") ? PBW_CELLS_MERGE : 0), &cells);
    if (!failed) {
        report(j, &cells, domain.box);
        failed = write_with(j, write_cells, &cells);
    }
    pbw_cells_free(&cells);
    return failed;
}

const command command_cells = {
    "cells", "compute Voronoi or power cells",
    "usage: pbw cells [options] points [-o output]...\n"
    "\n"
    "Computes the Voronoi cells of points, or with --weights the power cells.  Without --box those at the hull\n"
    "are unbounded.  Duplicates, points whose power cell is empty and points whose cell is outside of the box have\n"
    "empty cells.  With --periodic, points outside of the box are moved into it.\n"
    "\n"
    "input:   as for pbw mesh\n"
    "output:  .csv: id, volume (2D: area; unbounded: inf), centroid, number of facets;\n"
    "         .vtu .obj (cells as polyhedra, 2D: polygons), .svg (2D, coloured by area): those that are bounded\n"
    "\n",
    "csv vtu obj svg",
    { cells_options, input_options, build_options, output_options, common_options, NULL, NULL, NULL },
    run, 0, 0, 0, NULL, 0
};
