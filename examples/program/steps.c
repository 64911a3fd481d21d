/* steps.c: reads, triangulates, checks, describes; the options for that.
   In: a job with its options.  Out: its cloud, its mesh, lines of the report; or a failure in words. */
#include "program.h"
#include "pbw_generate.h"

const char *const smoothers[] = { "laplace", "lloyd", "odt", NULL };

const option input_options[] = {
    { "--dim", "2|3", "dimension; default 3, or 2 for files of two columns or of one z", WHOLE, 2, 3, NULL },
    { "--columns", "X,Y[,Z]", "which columns, by number from 1 or by name", PLAIN, 0, 0, NULL },
    { "--keep", "A,B", "tables: columns that the points keep, by number or name, for .csv .vtu ...; * is all",
      PLAIN, 0, 0, NULL },
    { "--decimal-comma", NULL, "tables: numbers such as 1,5; columns set apart by ; or blanks", SWITCH, 0, 0, NULL },
    { "--generate", "KIND N", "N points instead of an input: uniform gauss ball sphere lattice\n"
      "clusters lines spiral plane anisotropic moment", GENERATE, 1, 4e9, pbwgen_kinds },
    OPTION_SEED,
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

const option weight_options[] = {
    { "--weights", "COLUMN", "regular triangulation with the weights of that column", PLAIN, 0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

const option build_options[] = {
    { "--threads", "N", "default 0: all cores", WHOLE, 0, 256, NULL },
    { "--memory-limit", "SIZE", "such as 500M or 4G: fail rather than use more than that for the work", BYTES, 0, 0,
      NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

/* ---- reading ---- */

/* Makes z a height if all points have the same; returns whether they do. */
static int flatten(pbwio_cloud *cloud)
{
    const double z = cloud->points[2];
    size_t i;
    for (i = 0; i < cloud->count; i++) {
        if (cloud->points[3 * i + 2] < z || cloud->points[3 * i + 2] > z) {
            return 0;
        }
    }
    cloud->heights = fabs(z) > 0 ? (double *)malloc(cloud->count * sizeof *cloud->heights) : NULL;
    for (i = 0; i < cloud->count; i++) {
        memmove(cloud->points + 2 * i, cloud->points + 3 * i, 2 * sizeof(double));
        if (cloud->heights != NULL) {
            cloud->heights[i] = z;
        }
    }
    cloud->dim = 2;
    return 1;
}

/* Says what a file has and the cloud has not. */
static void warn_dropped(const job *j, const char *path, const pbwio_cloud *cloud)
{
    if (path != NULL && cloud->dropped[0] != 0) {
        warn(j, "%s: not kept: %s", path, cloud->dropped);
    }
}

int load(job *j, int flat)
{
    double start = now();
    pbwio_error error;
    pbwio_status status = PBWIO_OK;
    begin(j, "read", j->generate != NULL ? j->generate : j->input);
    if (j->generate != NULL) {
        const int kind = choice_of(j, "--generate"), dim = j->read.dim == 2 ? 2 : 3;
        pbw_status generated;
        j->stage = "generate";
        generated = pbwgen_points(kind < 0 ? 0 : kind, dim, j->count, (uint64_t)number_of(j, "--seed", 1), &j->build,
                                  &j->cloud);
        j->stage = NULL;
        if (generated != PBW_OK) {
            j->cloud.dim = dim;                      /* for the message */
            j->cloud.count = j->count;
            return explain(j, generated);
        }
    } else {
        j->stage = "read";
        status = pbwio_read(j->input, &j->read, &j->cloud, &error);
        j->stage = NULL;
    }
    if (status != PBWIO_OK || interrupted) {
        return explain_io(j, status, &error);
    }
    warn_dropped(j, j->input, &j->cloud);
    if (j->cloud.seed_count > 0 && j->command != &command_fill) {
        warn(j, "%s: its holes and regions, %zu in all, are not kept; pbw fill keeps them", j->input,
             j->cloud.seed_count);
    }
    if (flat && j->read.dim == 0 && j->cloud.dim == 3) {
        flatten(&j->cloud);
    }
    report_line(j, "%zu point%s in %dD%s, %zu face%s", COUNT(j->cloud.count), j->cloud.dim,
                j->cloud.weights != NULL ? ", weighted" : "", COUNT(j->cloud.triangle_count));
    if (j->cloud.taken[0] != 0) {
        report_line(j, "columns: %s", j->cloud.taken);
    }
    report_step(j, "read", now() - start, "%s", "");
    return 0;
}

void warn_of_heights(const job *j, size_t differ)
{
    if (differ > 0) {
        warn(j, "%zu point%s on another and of another height: that of the first one counts", differ,
             differ == 1 ? " is" : "s are");
    }
}

int load_queries(job *j)
{
    double start = now();
    pbwio_options read = j->read;
    pbwio_cloud *queries = &j->queries;
    pbwio_error error;
    pbwio_status status;
    begin(j, "read", j->second);
    read.weight = NULL;
    j->stage = "read";
    status = pbwio_read(j->second, &read, queries, &error);
    j->stage = NULL;
    if (status != PBWIO_OK) {
        return explain_io(j, status, &error);
    }
    warn_dropped(j, j->second, queries);
    if (queries->dim != j->cloud.dim && !(queries->dim == 3 && flatten(queries))) {
        return fail(j, "%s: %s in %dD, but points in %dD%s", j->second, j->command->second, queries->dim,
                    j->cloud.dim, queries->dim == 3 ? "; --dim 2 leaves z out" : "");
    }
    report_step(j, "read", now() - start, "%zu %s", queries->count,
                queries->count == 1 ? "query" : j->command->second);
    return 0;
}

/* ---- failures in words ---- */

/* The need is what pbw.h promises for uniform points. */
static int out_of_memory(const job *j)
{
    double need = (j->cloud.dim == 3 ? 300.0 : 105.0) * (double)j->cloud.count * 1e-6 + 1;
    char limit[80] = "";
    if (j->build.memory_limit > 0) {
        snprintf(limit, sizeof limit, " within --memory-limit %s", text_of(j, "--memory-limit"));
    }
    return fail(j, "out of memory%s: %zu point%s in %dD need%s about %.0f MB, and more where many lie on few lines",
                limit, COUNT(j->cloud.count), j->cloud.dim, j->cloud.count == 1 ? "s" : "", need);
}

int explain(const job *j, pbw_status status)
{
    return status == PBW_OK ? 0 : status == PBW_CANCELLED ? stopped(j) : status == PBW_ERROR_MEMORY ? out_of_memory(j)
         : fail(j, "%s", pbw_status_string(status));
}

int explain_io(const job *j, pbwio_status status, const pbwio_error *error)
{
    const char *limit = status == PBWIO_ERROR_MEMORY ? text_of(j, "--memory-limit") : NULL;
    return interrupted ? stopped(j) : fail(j, "%s%s%s", error->text, limit != NULL ? " within --memory-limit " : "",
                                           limit != NULL ? limit : "");
}

int explain_file(const job *j, pbw_status status, const char *why)
{
    const char *limit = status == PBW_ERROR_MEMORY ? text_of(j, "--memory-limit") : NULL;
    return status == PBW_CANCELLED ? stopped(j)
         : fail(j, "%s: %s%s%s", j->input, why[0] != 0 ? why : pbw_status_string(status),
                limit != NULL ? " within --memory-limit " : "", limit != NULL ? limit : "");
}

/* ---- the triangulation ---- */

int build(job *j)
{
    pbw_status status;
    if (writes_pages(j)) {                           /* pages can show who inserted what; not if memory is short */
        j->build.trace = (uint32_t *)malloc((j->cloud.count + 1) * sizeof(uint32_t));
    }
    status = pbw_triangulate(j->cloud.dim, j->cloud.points, j->cloud.weights, j->cloud.count, &j->build, &j->mesh);
    if (status != PBW_OK && !(status == PBW_DEGENERATE && j->command->may_be_flat)) {
        return explain(j, status);
    }
    report_step(j, "order", j->mesh.statistics.order_seconds, "%s", "");
    report_step(j, "build", j->mesh.statistics.build_seconds, "%s", "");
    report_step(j, "output", j->mesh.statistics.output_seconds, "%s", "");
    return 0;
}

int check(job *j)
{
    double start = now();
    pbw_report report;
    pbw_status status = pbw_check(&j->mesh, &j->build, &report);
    if (status != PBW_OK) {
        return explain(j, status);
    }
    report_step(j, "check", now() - start, "%s", report.valid ? "valid" : report.what);
    return report.valid ? 0 : fail(j, "the result is wrong: please report this");
}

const char *simplices(int dim, size_t count)
{
    return dim == 3 ? count == 1 ? "tetrahedron" : "tetrahedra"
         : dim == 2 ? count == 1 ? "triangle" : "triangles" : count == 1 ? "simplex" : "simplices";
}

void describe(const job *j)
{
    const pbw_mesh *mesh = &j->mesh;
    size_t i, hull = 0;
    char share[48] = "";
    for (i = 0; i < mesh->simplex_count * (size_t)(mesh->dim + 1); i++) {
        hull += mesh->neighbors[i] == PBW_NONE;
    }
    report_line(j, "%zu %s, %zu facet%s on the hull, %zu duplicate%s, %zu hidden point%s", mesh->simplex_count,
                simplices(mesh->dim, mesh->simplex_count), COUNT(hull), COUNT(mesh->duplicate_count),
                COUNT(mesh->hidden_count));
    if (mesh->point_count >= 10000) {                /* below, what the threads hold is most of it */
        snprintf(share, sizeof share, ", %.0f bytes a point",
                 (double)mesh->statistics.peak_bytes / (double)mesh->point_count);
    }
    report_line(j, "peak memory %.2f MB%s, hash %016llx", (double)mesh->statistics.peak_bytes * 1e-6, share,
                (unsigned long long)pbw_hash(mesh, NULL));
}

pbwsample_model model_of(const pbwio_cloud *cloud)
{
    pbwsample_model model;
    memset(&model, 0, sizeof model);
    model.points = cloud->points;
    model.point_count = cloud->count;
    model.triangles = cloud->triangles;
    model.triangle_count = cloud->triangle_count;
    return model;
}

/* ---- inside ---- */

int load_surface(job *j)
{
    const char *path = text_of(j, "--surface");
    const pbwio_cloud *surface = path != NULL ? &j->surface : &j->cloud;
    pbwio_options read;
    pbwio_error error;
    pbwsample_model model;
    pbwsample_report report;
    pbw_status status;
    if (!is_given(j, "--inside")) {
        return 0;
    }
    begin(j, "surface", path != NULL ? path : "");
    memset(&read, 0, sizeof read);
    read.build = &j->build;
    if (path != NULL && pbwio_read(path, &read, &j->surface, &error) != PBWIO_OK) {
        return interrupted ? stopped(j) : fail(j, "--surface: %s", error.text);
    }
    warn_dropped(j, path, &j->surface);
    if (surface->dim != 3 || surface->triangle_count == 0) {
        return fail(j, "--inside needs a model with faces in 3D, %s has none",
                    path != NULL ? path : j->input != NULL ? j->input : "what is generated");
    }
    model = model_of(surface);
    j->stage = "surface";
    status = pbwsample_inspect(&model, NULL, &report);
    j->stage = NULL;
    if (status != PBW_OK) {
        return fail(j, "%s: %s", path != NULL ? path : j->input, pbwsample_status_string(status));
    }
    j->open_surface = report.open_edges > 0 && report.turned_edges == 0;
    if (!report.closed) {
        warn(j, "the surface is not closed (%zu open, %zu crowded, %zu turned edge%s): what is inside is decided by "
             "two of three rays", report.open_edges, report.crowded_edges, COUNT(report.turned_edges));
        describe_surface(j, surface, 0);
    }
    return 0;
}

/* Finds whether an open surface has an inside: it winds by more than three quarters around the centre of a
   tetrahedron, as a bowl does.  A flat sheet winds by at most half, one with waves by a little more. */
static pbw_status winds_around(const job *j, const pbwio_cloud *cloud, const double *centre, int *winds)
{
    pbw_surface surface;
    pbw_status status = pbw_surface_create(cloud->points, cloud->count, cloud->triangles, cloud->triangle_count,
                                           &j->build, &surface);
    size_t i;
    for (i = 0, *winds = 0; status == PBW_OK && i < j->mesh.simplex_count && !*winds; i++) {
        *winds = fabs(pbw_surface_winding(&surface, centre + 3 * i)) > 0.75;
    }
    pbw_surface_free(&surface);
    return status;
}

/* The exit status where an option asks for what is inside, and that is nothing. */
static int nothing_inside(const job *j, int winds)
{
    const char *path = text_of(j, "--surface") != NULL ? text_of(j, "--surface") : j->input;
    return winds ? fail(j, "%s: nothing is inside: no tetrahedron has its centre there; are the points and the "
                        "surface at the same place, in the same unit?", path)
         : fail(j, "%s: nothing is inside: the surface is an open sheet; close it (pbw check says where it is open)",
                path);
}

int mark_inside(job *j)
{
    const pbwio_cloud *surface = is_given(j, "--surface") ? &j->surface : &j->cloud;
    pbwsample_model model = model_of(surface);
    pbw_status status = PBW_ERROR_MEMORY;
    double start = now(), *centre;
    size_t i, k, kept = 0;
    int winds = 1;
    if (j->mesh.dim != 3) {
        return fail(j, "--inside needs points in 3D");
    }
    begin(j, "inside", "");
    j->stage = "inside";
    centre = (double *)calloc(j->mesh.simplex_count + 1, 3 * sizeof *centre);
    j->inside = (unsigned char *)calloc(j->mesh.simplex_count + 1, 1);
    for (i = 0; i < j->mesh.simplex_count && centre != NULL; i++) {
        for (k = 0; k < 12; k++) {
            centre[3 * i + k % 3] += 0.25 * j->mesh.points[3 * (size_t)j->mesh.simplices[4 * i + k / 3] + k % 3];
        }
    }
    if (centre != NULL && j->inside != NULL) {
        status = pbwsample_inside(&model, centre, j->mesh.simplex_count, NULL, j->inside);
    }
    if (status == PBW_OK && j->open_surface && winds_around(j, surface, centre, &winds) != PBW_OK) {
        status = PBW_ERROR_MEMORY;
    }
    free(centre);
    j->stage = NULL;
    if (status != PBW_OK) {
        return fail(j, "%s", pbwsample_status_string(status));
    }
    for (i = 0; i < j->mesh.simplex_count; i++) {
        kept += j->inside[i];
    }
    report_step(j, "inside", now() - start, "%zu %s", kept, simplices(j->mesh.dim, kept));
    return is_given(j, "--inside") && (kept == 0 || !winds) ? nothing_inside(j, winds) : 0;
}
