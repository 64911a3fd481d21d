/* mesh.c: pbw mesh. */
#include "program.h"

static const option mesh_options[] = {
    { "--any-order", NULL, "skip the canonical order of simplices", SWITCH, 0, 0, NULL },
    OPTION_NO_CHECK,
    OPTION_NO_ORPHANS,
    { "--longest", "L", "only triangles or tetrahedra without an edge longer than L", POSITIVE, 0, 0, NULL },
    OPTION_ALPHA("only triangles or tetrahedra with a circumradius of at most R: the alpha shape; with\n"
      "weights, the radius is that of the orthogonal circle or sphere", POSITIVE),
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

/* Columns and heights go to the outputs. */
static void carry_columns(job *j)
{
    pbwio_cloud *c = &j->cloud;
    if (c->heights != NULL) {
        warn_of_heights(j, unify(j->mesh.canonical, c->count, c->heights));
    }
    j->write.heights = c->heights;
    j->write.columns = c->columns;
    j->write.column_count = c->column_count;
    j->write.base = c->base;
    j->write.groups = c->groups;
    j->write.group_count = c->group_count;
    j->write.point_groups = c->point_groups;
}

/* ---- parts by size ---- */

static double longest_edge(const pbw_mesh *m, size_t simplex)
{
    const size_t dim = (size_t)m->dim;
    const pbw_index *corner = m->simplices + (dim + 1) * simplex;
    double most = 0;
    size_t i, k, x;
    for (i = 1; i <= dim; i++) {
        for (k = 0; k < i; k++) {
            double d[3] = { 0 }, scale = 0;          /* so that no square is out of range */
            for (x = 0; x < dim; x++) {
                d[x] = m->points[dim * corner[i] + x] - m->points[dim * corner[k] + x];
                scale = fmax(scale, fabs(d[x]));
            }
            most = fmax(most, scale * sqrt(pow(d[0] / scale, 2) + pow(d[1] / scale, 2) + pow(d[2] / scale, 2)));
        }
    }
    return most;
}

/* The radius of the sphere that is orthogonal to the balls of the corners (without weights: of the circumscribed
   sphere), up to rounding; infinite where the simplex is flat.  Its centre c, seen from the first corner, is where
   e . c = (|e|^2 + w0 - w) / 2 for each edge e from there to a corner of weight w: Cramer's rule, in the plane with a
   third edge across.  Edges are scaled to 1, so that no square is out of range. */
static double radius_of(const pbw_mesh *m, size_t simplex)
{
    const size_t dim = (size_t)m->dim;
    const pbw_index *corner = m->simplices + (dim + 1) * simplex;
    double e[3][3] = { { 0 }, { 0 }, { 0, 0, 1 } }, h[3] = { 0 }, c[3] = { 0 }, scale = 0, det = 0, power;
    size_t i, k;
    for (i = 0; i < dim * dim; i++) {
        e[i / dim][i % dim] = m->points[dim * corner[i / dim + 1] + i % dim] - m->points[dim * corner[0] + i % dim];
        scale = fmax(scale, fabs(e[i / dim][i % dim]));
    }
    power = m->weights != NULL ? -m->weights[corner[0]] / scale / scale : 0;
    for (i = 0; i < dim; i++) {
        for (k = 0; k < dim; k++) {
            e[i][k] /= scale;
            h[i] += e[i][k] * e[i][k] / 2;
        }
        h[i] -= m->weights != NULL ? (power + m->weights[corner[i + 1]] / scale / scale) / 2 : 0;
    }
    for (i = 0; i < 3; i++) {
        const double *p = e[(i + 1) % 3], *q = e[(i + 2) % 3];
        for (k = 0; k < 3; k++) {
            const double across = p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3];
            c[k] += h[i] * across;
            det += i == 0 ? e[0][k] * across : 0;
        }
    }
    for (k = 0; k < 3; k++) {
        power += c[k] / det * (c[k] / det);
    }
    return power <= DBL_MAX ? scale * sqrt(fmax(power, 0)) : HUGE_VAL;
}

/* Marks what --longest and --alpha leave, of what is marked already.  Returns 0 or the exit status. */
static int mark_small(job *j)
{
    const double start = now(), longest = number_of(j, "--longest", HUGE_VAL);
    const double alpha = number_of(j, "--alpha", HUGE_VAL);
    const size_t count = j->mesh.simplex_count;
    double least_length = HUGE_VAL, least_radius = HUGE_VAL;
    size_t i, kept = 0;
    if (j->inside == NULL) {
        j->inside = (unsigned char *)malloc(count + 1);
        if (j->inside == NULL) {
            return fail(j, "out of memory");
        }
        memset(j->inside, 1, count);
    }
    for (i = 0; i < count; i++) {
        if (j->inside[i]) {
            const double length = longest_edge(&j->mesh, i), radius = radius_of(&j->mesh, i);
            least_length = fmin(least_length, length);
            least_radius = fmin(least_radius, radius);
            j->inside[i] = length <= longest && radius <= alpha;
            kept += j->inside[i];
        }
    }
    if (kept == 0) {
        return fail(j, "nothing is left: the shortest longest edge is %.6g, the least radius %.6g", least_length,
                    least_radius);
    }
    report_step(j, "parts", now() - start, "%zu of %zu %s", kept, count, simplices(j->mesh.dim, count));
    return 0;
}

static int run(job *j)
{
    int status = load(j, 1), i;
    for (i = 0; status == 0 && j->cloud.dim == 3 && i < j->outputs; i++) {
        if (strcmp(ending_of(j, j->output[i]), "geojson") == 0) {
            status = fail(j, "%s: GeoJSON holds polygons of the plane; --dim 2 takes z for heights", j->output[i]);
        }
    }
    status = status != 0 ? status : load_surface(j);
    status = status != 0 ? status : build(j);
    status = status != 0 || is_given(j, "--no-check") ? status : check(j);
    if (status == 0) {
        describe(j);
    }
    if (status == 0 && is_given(j, "--inside")) {
        status = mark_inside(j);
    }
    if (status == 0 && (is_given(j, "--longest") || is_given(j, "--alpha"))) {
        status = mark_small(j);
    }
    j->write.keep = j->picture.keep = j->inside;
    if (status == 0) {
        carry_columns(j);
    }
    return status != 0 ? status : write_mesh(j);
}

const command command_mesh = {
    .name = "mesh",
    .summary = "triangulate points; also without its name",
    .usage =
    "usage: pbw [mesh] [options] input [-o output]...\n"
    "\n"
    "Exact Delaunay triangulation of the points of a file, or with --weights the regular one.\n"
    "\n"
    "input:   .obj .ply .stl .off .node .ele .poly .smesh .msh .mesh .inp .su2 .vtu .vtk .json .geojson, tables\n"
    "         (.xyz .csv .txt ...), molecules (.xyz), and all these with .gz; - is the standard input\n"
    "output:  .vtu .msh .msh2 .mesh .inp .su2 .node .ele .neigh .face .edge (simplices, boundary),\n"
    "         .obj .ply .stl .off (hull), .xyz .csv (points), .svg (picture), .html (page to look around\n"
    "         in), .geojson (triangles of the plane); any number of them\n"
    "\n",
    .writes = "vtu msh msh2 mesh inp su2 node ele neigh face edge obj "
              "ply stl off xyz csv txt pts asc dat tsv svg html geojson",
    .options = { mesh_options, inside_options, look_options, input_options, weight_options, build_options,
                 output_options, text_options, common_options, NULL },
    .run = run,
};
