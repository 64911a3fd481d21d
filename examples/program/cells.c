/* cells.c: pbw cells.
   In: points; a box, a lattice or a clip.  Out: tables, files of shapes, pictures and pages of their cells. */
#include "program.h"

static const option cells_options[] = {
    { "--box", "X,Y[,Z],X,Y[,Z]", "low corner and high corner: cells end there", BOX, 0, 0, NULL },
    { "--clip", "FILE", "cells end there.  2D: rings; a ring ends with its first corner, what is in an odd number\n"
      "of rings is inside, neighbours that share edges are one.  3D: a closed convex surface, as .obj .ply .stl .off",
      PLAIN, 0, 0, NULL },
    { "--periodic", "xyz", "the axes along which the box repeats", AXES, 0, 0, NULL },
    { "--lattice", "X,Y[,Z],...", "all repeats by these vectors, at any angles: in 2D two, in 3D three",
      LATTICE, 0, 0, NULL },
    { "--gpu", NULL, "mesh and cells by an NVIDIA GPU, for .csv: the same bytes (uneven points in a\n"
      "periodic box: the same up to rounding); `make GPU=1` builds that in", SWITCH, 0, 0, NULL },
    { "--merge", NULL, "the true diagram: centres that coincide are one corner, facets without area left out", SWITCH,
      0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

/* ---- outputs ---- */

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

static int is_seen(const char *ending)               /* a picture or a page */
{
    return strcmp(ending, "svg") == 0 || strcmp(ending, "html") == 0;
}

static int shows_pictures(const job *j)
{
    int i, seen = 0;
    for (i = 0; i < j->outputs; i++) {
        seen |= is_seen(ending_of(j, j->output[i]));
    }
    return seen;
}

/* user: pointers to the cells, and to those of pictures and pages. */
static pbwio_status write_cells(job *j, const char *path, const char *ending, void *user, pbwio_error *error)
{
    pbw_cells *cells = ((pbw_cells **)user)[is_seen(ending)];
    return strcmp(ending, "csv") == 0 ? pbwio_save(path, emit, cells, &j->build, error)
         : strcmp(ending, "html") == 0
         ? write_cell_page(j, path, cells, cells->dim == 2 && is_given(j, "--clip"), error)
         : write_diagram(path, ending, cells, error);
}

/* ---- the report ---- */

static int is_bounded(const pbw_domain *domain)
{
    return domain->box != NULL || domain->lattice != NULL || domain->ring_count != 0 || domain->plane_count != 0;
}

/* The domain's volume; clip: that of planes or rings. */
static double whole_of(const pbw_domain *domain, int dim, double clip)
{
    double whole = domain->box != NULL ? 1 : clip;
    int k;
    if (domain->lattice != NULL) {
        const double *a = domain->lattice, *b = a + dim, *c = b + dim;
        return fabs(dim == 2 ? a[0] * b[1] - a[1] * b[0]
                    : a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                      + a[2] * (b[0] * c[1] - b[1] * c[0]));
    }
    for (k = 0; k < dim && domain->box != NULL; k++) {
        whole *= domain->box[dim + k] - domain->box[k];
    }
    return whole;
}

/* The sum has an error of one rounding (Neumaier 1974), so that it shows that of the cells. */
static void report(const job *j, const pbw_cells *cells, const pbw_domain *domain, double clip)
{
    const char *volume = cells->dim == 3 ? "volume" : "area";
    const double whole = whole_of(domain, cells->dim, clip);
    double sum = 0, rest = 0;
    size_t i, empty = 0, unbounded = 0;
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
    report_line(j, "%zu cell%s, %zu of them empty, %zu unbounded; %zu facet%s", COUNT(cells->cell_count), empty,
                unbounded, COUNT(cells->facet_count));
    if (!is_bounded(domain)) {
        report_line(j, "%s %.15g, the sum of bounded cells", volume, sum + rest);
        return;
    }
    report_line(j, "%s %.15g, the sum of cells; %.15g, the %s; relative difference %.1e", volume, sum + rest, whole,
                domain->box != NULL || domain->lattice != NULL ? "box" : cells->dim == 3 ? "body" : "polygon",
                fabs(sum - whole + rest) / whole);
}

/* ---- the clip ---- */

/* Says where rings cross, by their numbers from 1, or what else is wrong with them. */
static int refuse_rings(const job *j, const pbw_domain *domain, const pbw_rings *found)
{
    const char *path = text_of(j, "--clip");
    const double *a = domain->rings + 2 * found->edges[0], *b = domain->rings + 2 * found->edges[1];
    size_t ring[2] = { 0, 0 }, i;
    for (i = 0; i < domain->ring_count; i++) {
        ring[0] += domain->ring_first[i] <= found->edges[0];
        ring[1] += domain->ring_first[i] <= found->edges[1];
    }
    return found->edges[0] == found->edges[1]
         ? fail(j, "%s: the rings enclose nothing: they have no area, or cancel each other out, or coordinates are "
                "beyond 1e-57 to 1e60", path)
         : fail(j, "%s: the edge of ring %zu from (%.15g, %.15g) and that of ring %zu from (%.15g, %.15g) cross near "
                "(%.15g, %.15g)", path, ring[0], a[0], a[1], ring[1], b[0], b[1], found->place[0], found->place[1]);
}

/* The rings of --clip: each ends where its first corner comes again, the last one with the file. */
static int load_rings(job *j, pbw_domain *domain, pbwio_cloud *cloud, size_t **first, double *area)
{
    size_t i, count = 0, begin = 0, rings = 0;
    pbw_rings found;
    pbw_status status;
    *first = (size_t *)malloc((cloud->count + 2) * sizeof **first);
    if (*first == NULL) {
        return fail(j, "out of memory");
    }
    (*first)[0] = 0;
    for (i = 0; i < cloud->count; i++) {
        double *x = cloud->points + 2 * i;
        const int closes = count > begin && memcmp(cloud->points + 2 * begin, x, 2 * sizeof *x) == 0;
        if (!closes) {
            memmove(cloud->points + 2 * count++, x, 2 * sizeof *x);
        }
        if (closes || (i + 1 == cloud->count && count > begin)) {
            begin = (*first)[++rings] = count;
        }
    }
    domain->rings = cloud->points;
    domain->ring_first = *first;
    domain->ring_count = rings;
    status = pbw_cells_rings(domain, &j->build, &found);
    *area = found.area;
    return status == PBW_ERROR_ARGUMENT ? refuse_rings(j, domain, &found) : explain(j, status);
}

/* Beyond a plane: n.x - c. */
static double beyond(const double *plane, const double *x)
{
    return plane[0] * x[0] + plane[1] * x[1] + plane[2] * x[2] - plane[3];
}

/* The plane of a triangle, its normal of length 1 and away from a point.  Returns 6 times the volume between them. */
static double plane_of(const pbwio_cloud *c, size_t triangle, const double *middle, double *plane)
{
    const pbw_index *t = c->triangles + 3 * triangle;
    const double *a = c->points + 3 * (size_t)t[0], *b = c->points + 3 * (size_t)t[1];
    const double *d = c->points + 3 * (size_t)t[2];
    double length, far;
    size_t k;
    for (k = 0; k < 3; k++) {
        const size_t m = (k + 1) % 3, n = (k + 2) % 3;
        plane[k] = (b[m] - a[m]) * (d[n] - a[n]) - (b[n] - a[n]) * (d[m] - a[m]);
    }
    length = sqrt(plane[0] * plane[0] + plane[1] * plane[1] + plane[2] * plane[2]);
    plane[3] = 0;
    plane[3] = beyond(plane, a);
    far = beyond(plane, middle);
    for (k = 0; k < 4 && length > 0; k++) {
        plane[k] /= far > 0 ? -length : length;
    }
    return fabs(far);
}

/* The body of --clip: the half-space of each triangle, one for those in a plane.  All points must be in all of them,
   to 1e-9 of the size.  volume: of the body. */
static int load_body(job *j, pbw_domain *domain, const pbwio_cloud *c, double **planes, double *volume)
{
    const char *path = text_of(j, "--clip");
    double middle[3] = { 0, 0, 0 }, size = 0;
    size_t i, t, k, count = 0;
    *planes = (double *)malloc((c->triangle_count + 1) * 4 * sizeof **planes);
    if (*planes == NULL) {
        return fail(j, "out of memory");
    }
    for (i = 0; i < 3 * c->triangle_count; i++) {
        for (k = 0; k < 3; k++) {
            middle[k] += c->points[3 * (size_t)c->triangles[i] + k] / (double)(3 * c->triangle_count);
        }
    }
    for (i = 0; i < 3 * c->triangle_count; i++) {
        for (k = 0; k < 3; k++) {
            size = fmax(size, fabs(c->points[3 * (size_t)c->triangles[i] + k] - middle[k]));
        }
    }
    for (*volume = 0, t = 0; t < c->triangle_count; t++) {
        double *plane = *planes + 4 * count;
        const double more = plane_of(c, t, middle, plane);
        int known = !(more > 0);
        *volume += more / 6;
        for (i = 0; i < count && !known; i++) {
            for (known = 1, k = 0; k < 3; k++) {
                known &= fabs(beyond(*planes + 4 * i, c->points + 3 * (size_t)c->triangles[3 * t + k])) < 1e-9 * size;
            }
        }
        for (i = 0; i < 3 * c->triangle_count && !known; i++) {
            if (beyond(plane, c->points + 3 * (size_t)c->triangles[i]) > 1e-9 * size) {
                return fail(j, "%s: the surface is not convex", path);
            }
        }
        count += !known;
    }
    domain->planes = *planes;
    domain->plane_count = count;
    return count > 3 ? 0 : fail(j, "%s: not a surface of triangles around a body", path);
}

static int load_clip(job *j, pbw_domain *domain, pbwio_cloud *cloud, void **kept, double *volume)
{
    pbwio_options read;
    pbwio_error error;
    size_t *first = NULL;
    double *planes = NULL;
    int failed;
    memset(&read, 0, sizeof read);
    read.dim = j->cloud.dim;
    read.flags = PBWIO_CLOSED_RINGS;                 /* part the rings */
    read.build = &j->build;
    if (pbwio_read(text_of(j, "--clip"), &read, cloud, &error) != PBWIO_OK) {
        return interrupted ? stopped(j) : fail(j, "--clip: %s", error.text);
    }
    failed = read.dim == 2 ? load_rings(j, domain, cloud, &first, volume)
           : load_body(j, domain, cloud, &planes, volume);
    *kept = read.dim == 2 ? (void *)first : (void *)planes;
    return failed;
}

/* ---- the cells ---- */

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

/* Unless products of four and five lengths of the size of the points' box are doubles. */
static void warn_of_range(const job *j)
{
    const pbwio_cloud *c = &j->cloud;
    const size_t dim = (size_t)c->dim;
    double extent = 0;
    size_t i;
    for (i = dim; i < dim * c->count; i++) {
        extent = fmax(extent, fabs(c->points[i] - c->points[i % dim]));
    }
    if (extent != 0 && (extent < 1e-57 || extent > 1e60)) {
        warn(j, "points beyond 1e-57 to 1e60 of each other: volumes over- or underflow");
    }
}

static int make(job *j, const pbw_domain *domain, unsigned what, pbw_cells *cells)
{
    const pbwio_cloud *c = &j->cloud;
    pbw_status status;
    const int repeats = domain->periodic != 0 || domain->lattice != NULL;
    double start;
    int failed = 0;
    if (!repeats) {
        failed = build(j);
        if (!failed) {
            describe(j);
        }
    }
    start = now();
    if (failed) {
        return failed;
    }
    if (!repeats && j->mesh.simplex_count == 0 && !is_bounded(domain)) {
        return fail(j, "the points do not span the %s; with --box or --clip they have cells",
                    c->dim == 3 ? "space" : "plane");
    }
    status = !repeats ? pbw_cells_of(&j->mesh, domain, what, &j->build, cells)
           : pbw_cells_periodic(c->dim, c->points, c->weights, c->count, domain, what, &j->build, cells);
    if (status == PBW_ERROR_ARGUMENT && domain->lattice != NULL) {
        return fail(j, "--lattice %s: the vectors are flat, or so skew that neighbours are more than 127 of them "
                    "away: others make the same lattice; or weights differ too much", text_of(j, "--lattice"));
    }
    if (status == PBW_ERROR_ARGUMENT && domain->plane_count != 0) {
        return fail(j, "%s: the surface is not closed", text_of(j, "--clip"));
    }
    failed = status != PBW_ERROR_ARGUMENT || domain->ring_count == 0 ? explain(j, status)
           : fail(j, "coordinates or weights beyond 1e-57 to 1e60, which --clip %s does not take",
                  text_of(j, "--clip"));
    if (!failed) {
        report_step(j, "cells", now() - start, "%s", "");
        warn_of_range(j);
    }
    return failed;
}

static int make_by_gpu(job *j, const pbw_domain *domain, pbw_cells *cells)
{
    const double start = now();
    const int failed = gpu_cells(j, domain, cells);
    if (!failed) {
        report_step(j, "cells", now() - start, "%s", "with the mesh, on the GPU");
        warn_of_range(j);
    }
    return failed;
}

/* What the cells must have for the outputs; -1: an output cannot be. */
static int contents_of(const job *j)
{
    unsigned what = PBW_CELLS_FACETS | (is_given(j, "--merge") ? PBW_CELLS_MERGE : 0);
    int i;
    for (i = 0; i < j->outputs; i++) {
        const char *ending = ending_of(j, j->output[i]);
        what |= strcmp(ending, "csv") != 0 ? PBW_CELLS_SHAPES : 0;
        if ((strcmp(ending, "svg") == 0 || strcmp(ending, "geojson") == 0) && j->cloud.dim == 3) {
            (void)fail(j, "%s: .%s of cells needs points in 2D", j->output[i], ending);
            return -1;
        }
    }
    return (int)what;
}

/* Cells that end at a box a tenth larger than the points. */
static int make_bounded(job *j, unsigned what, pbw_cells *cells)
{
    const int dim = j->mesh.dim;
    pbw_domain domain;
    double box[6], most = 0;
    size_t i;
    int k;
    for (k = 0; k < dim; k++) {
        box[k] = box[dim + k] = j->mesh.points[k];
        for (i = 0; i < j->mesh.point_count; i++) {
            box[k] = fmin(box[k], j->mesh.points[(size_t)dim * i + (size_t)k]);
            box[dim + k] = fmax(box[dim + k], j->mesh.points[(size_t)dim * i + (size_t)k]);
        }
        most = fmax(most, box[dim + k] - box[k]);
    }
    for (k = 0; k < dim; k++) {
        box[k] -= 0.1 * most;
        box[dim + k] += 0.1 * most;
    }
    memset(&domain, 0, sizeof domain);
    domain.box = box;
    return explain(j, pbw_cells_of(&j->mesh, &domain, what, &j->build, cells));
}

/* ---- the command ---- */

/* Does the domain say that points are in 3D, even where all have one z? */
static int is_solid(const job *j)
{
    static const char *const body[] = { "obj", "ply", "stl", "off", NULL };
    const char *clip = text_of(j, "--clip"), *dot = clip != NULL ? strrchr(clip, '.') : NULL;
    double box[9];
    int i, found = (is_given(j, "--box") && vector_of(j, "--box", 6, box))
                || (is_given(j, "--lattice") && vector_of(j, "--lattice", 9, box));
    for (i = 0; dot != NULL && body[i] != NULL; i++) {
        found |= strcmp(dot + 1, body[i]) == 0;
    }
    return found;
}

static int check_domain(const job *j, pbw_domain *domain, double *box)
{
    if (is_given(j, "--box") && !vector_of(j, "--box", 2 * j->cloud.dim, box)) {
        return fail(j, "--box %s: %d numbers are needed for points in %dD", text_of(j, "--box"), 2 * j->cloud.dim,
                    j->cloud.dim);
    }
    if (is_given(j, "--lattice") && !vector_of(j, "--lattice", j->cloud.dim * j->cloud.dim, box)) {
        return fail(j, "--lattice %s: %d numbers are needed for points in %dD", text_of(j, "--lattice"),
                    j->cloud.dim * j->cloud.dim, j->cloud.dim);
    }
    if (domain->periodic >> j->cloud.dim != 0) {
        return fail(j, "--periodic %s: the points are in 2D", text_of(j, "--periodic"));
    }
    domain->box = is_given(j, "--box") ? box : NULL;
    domain->lattice = is_given(j, "--lattice") ? box : NULL;
    return 0;
}

/* Files of shapes have the cells that are bounded; the exit status where there are none. */
static int draws_nothing(const job *j, const pbw_cells *cells)
{
    size_t i;
    int k;
    for (k = 0; k < j->outputs; k++) {
        const char *ending = ending_of(j, j->output[k]);
        for (i = 0; strcmp(ending, "csv") != 0 && !is_seen(ending) && i < cells->cell_count && !is_drawn(cells, i);
             i++) {
        }
        if (i == cells->cell_count) {
            return fail(j, "%s: no cell is bounded: --box or --clip ends them", j->output[k]);
        }
    }
    return 0;
}

static int run(job *j)
{
    pbwio_cloud clip;
    pbw_domain domain;
    pbw_cells cells, bounded, *shown[2];
    void *kept = NULL;
    double box[9], clipped = 0;
    int failed, what = 0;
    memset(&domain, 0, sizeof domain);
    memset(&cells, 0, sizeof cells);
    memset(&bounded, 0, sizeof bounded);
    memset(&clip, 0, sizeof clip);
    domain.periodic = axes_of(j);
    failed = load(j, !is_solid(j));
    failed = failed ? failed : check_domain(j, &domain, box);
    if (!failed && is_given(j, "--clip")) {
        failed = load_clip(j, &domain, &clip, &kept, &clipped);
    }
    if (!failed) {
        what = contents_of(j);
        failed = what < 0 ? FAILURE : is_given(j, "--gpu") ? make_by_gpu(j, &domain, &cells)
               : make(j, &domain, (unsigned)what, &cells);
    }
    if (!failed) {
        report(j, &cells, &domain, clipped);
        failed = draws_nothing(j, &cells);
    }
    if (!failed) {
        shown[0] = shown[1] = &cells;
        if (!is_bounded(&domain) && shows_pictures(j)) {
            shown[1] = &bounded;
            failed = make_bounded(j, (unsigned)what, &bounded);
        }
    }
    if (!failed) {
        failed = write_with(j, write_cells, shown);
    }
    pbw_cells_free(&bounded);
    (is_given(j, "--gpu") ? gpu_free : pbw_cells_free)(&cells);
    pbwio_free(&clip);
    free(kept);
    return failed;
}

const command command_cells = {
    .name = "cells",
    .summary = "compute Voronoi or power cells",
    .usage =
    "usage: pbw cells [options] points [-o output]...\n"
    "\n"
    "Computes the Voronoi cells of points, or with --weights the power cells.  Without --box or --clip those at the\n"
    "hull are unbounded.  Duplicates, points whose power cell is empty and points whose cell is outside have\n"
    "empty cells.  With --periodic, points outside of the box are moved into it; with --lattice, by its vectors\n"
    "near the origin.  One point, points on a line and points in a plane have cells in a box, lattice or clip; a box of\n"
    "six numbers or a lattice of nine means that points are in 3D.\n"
    "\n"
    "input:   as for pbw mesh\n"
    "output:  .csv: id, volume (2D: area; unbounded: inf), centroid, number of facets;\n"
    "         .vtu .obj (cells as polyhedra, 2D: polygons) .geojson (2D): those that are bounded; .svg (2D, coloured\n"
    "         by area);\n"
    "         .html: a page to look at them: cut, exploded, coloured by volume or number of facets.  In .svg and\n"
    "         .html, unbounded cells end at a box a tenth larger than the points\n"
    "\n",
    .writes = "csv vtu obj svg html geojson",
    .options = { cells_options, input_options, weight_options, build_options, output_options, common_options, NULL },
    .run = run,
    .may_be_flat = 1,
};
