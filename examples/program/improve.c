/* improve.c: pbw improve.
   In: tetrahedra, or triangles of a plane.  Out: better ones, with the groups of the input, and a report. */
#include "domain.h"

static const option improve_options[] = {
    OPTION_TARGET("; default 30"),
    OPTION_SECONDS,
    OPTION_FEATURE_ANGLE,
    OPTION_SIZE("about"),
    { "--error", "FILE", "first split and contract edges for sizes from errors, one number a tetrahedron, of\n"
      "linear elements in the energy norm", PLAIN, 0, 0, NULL },
    OPTION_COUNT("with --error: about how many tetrahedra it makes, default the number before"),
    OPTION_SMOOTH("move points to better means: laplace, lloyd or odt, the default of triangles"),
    OPTION_ROUNDS("of --smooth, default 5"),
    { "--only-smooth", NULL, "nothing but --smooth", SWITCH, 0, 0, NULL },
    OPTION_QUALITY,
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

/* ---- the report ---- */

void describe_quality(const job *j, const char *when, const pbw_quality *q)
{
    report_line(j, "%sdihedral angles %.2f, %.2f (0.1 %%), %.2f (1 %%) to %.2f degrees; "
                "below 5, 10, 20, 30: %zu, %zu, %zu, %zu", when, q->least, q->permille, q->percent, q->largest,
                q->below[0], q->below[1], q->below[2], q->below[3]);
}

void describe_histogram(const job *j, const pbw_quality *q)
{
    char line[256];
    size_t i, used = 0;
    for (i = 0; i < 18; i++) {
        used += (size_t)snprintf(line + used, sizeof line - used, " %zu", q->bins[i]);
    }
    report_line(j, "angles in each 10 degrees:%s", line);
}

void describe_measures(const job *j, const pbw_tets *tets)
{
    pbw_spread s;
    int i;
    for (i = 0; i < PBW_MEASURES && pbw_tets_spread(tets, (pbw_measure)i, &j->build, &s); i++) {
        report_line(j, "%-16s least %.7g, 0.1 %% %.7g, 1 %% %.7g, mean %.7g, most %.7g",
                    pbw_measure_name((pbw_measure)i), s.least, s.permille, s.percent, s.mean, s.most);
    }
}

/* The writers' view of tetrahedra. */
void show_tets(job *j, const pbw_tets *tets)
{
    memset(&j->mesh, 0, sizeof j->mesh);
    j->mesh.dim = 3;
    j->mesh.points = tets->points;
    j->mesh.point_count = tets->point_count;
    j->mesh.simplices = tets->corners;
    j->mesh.simplex_count = tets->tet_count;
    j->mesh.neighbors = tets->neighbors;
}

static void describe_moves(const job *j, const pbw_improve_report *r)
{
    report_line(j, "%zu edge%s removed, %zu of the boundary; %zu point%s moved, %zu on the boundary; %zu peeled off, "
                "%zu flip%s, %zu contraction%s, %zu insertion%s; %zu pass%s",
                COUNT(r->removals + r->boundary_removals), r->boundary_removals, COUNT(r->smoothings + r->slides),
                r->slides, r->peelings, COUNT(r->flips), COUNT(r->contractions), COUNT(r->insertions),
                (size_t)r->passes, r->passes == 1 ? "" : "es");
    if (r->splits > 0) {
        report_line(j, "edges split for sizes: %zu", r->splits);
    }
    if (r->rounds > 0) {
        report_line(j, "before that, %zu round%s of smoothing: %zu move%s", COUNT(r->rounds), COUNT(r->moves));
    }
    if (r->left > 0) {
        report_line(j, "below the target in the end: %zu", r->left);
    }
}

/* ---- sizes from errors ---- */

/* Reads a number for each tetrahedron; returns NULL after a message. */
static double *read_errors(const job *j, const char *path, size_t count)
{
    double *error = (double *)malloc((count + 1) * sizeof *error);
    FILE *file = fopen(path, "r");
    size_t i = 0;
    while (error != NULL && file != NULL && i <= count && fscanf(file, "%lf", error + i) == 1 && error[i] >= 0) {
        i++;
    }
    if (file != NULL) {
        fclose(file);
    }
    if (i == count && error != NULL && file != NULL) {
        return error;
    }
    fail(j, error == NULL ? "%s: out of memory" : file == NULL ? "%s: it cannot be read"
         : "%s: it has other than one number a tetrahedron, all of 0 or more", path);
    free(error);
    return NULL;
}

/* Sizes at points, of --size or --error; *sizes stays NULL if neither is given.  Returns 0 or the exit status. */
static int make_sizes(const job *j, const pbw_tets *in, double **sizes)
{
    const char *path = text_of(j, "--error");
    size_t i;
    if (path == NULL && !is_given(j, "--size")) {
        return 0;
    }
    *sizes = (double *)malloc((in->point_count + 1) * sizeof **sizes);
    if (*sizes == NULL) {
        return fail(j, "out of memory");
    }
    for (i = 0; i < in->point_count; i++) {
        (*sizes)[i] = size_at_point(j, i);
        if (!((*sizes)[i] > 0)) {
            return fail(j, "--size %s: it is %g at point %zu, a number above 0 is needed", text_of(j, "--size"),
                        (*sizes)[i], i + (size_t)j->cloud.base);
        }
    }
    if (path != NULL) {
        double *error = read_errors(j, path, in->tet_count);
        if (error == NULL) {
            return FAILURE;
        }
        pbw_tets_sizes(in, error, (size_t)number_of(j, "--count", (double)in->tet_count), *sizes);
        free(error);
    }
    return 0;
}

/* ---- groups of the input: in and out ---- */

/* Points of groups that have a name stay; references without one are those of points that do. */
static unsigned char *marks_of_groups(const pbwio_cloud *c)
{
    unsigned char *marks = (unsigned char *)calloc(c->count + 1, 1);
    size_t i;
    for (i = 0; marks != NULL && c->point_groups != NULL && i < c->count; i++) {
        if (c->point_groups[i] != PBW_NONE && c->groups[c->point_groups[i]].name != NULL) {
            marks[i] = PBW_TETS_FIXED;
        }
    }
    return marks;
}

/* Writes the mesh with the groups of what each element and point was in the input. */
static int write_better(job *j, const pbw_tets *better)
{
    const pbwio_cloud *c = &j->cloud;
    pbwio_output *o = &j->write;
    pbw_index *edge_groups = (pbw_index *)malloc((better->edge_count + 1) * sizeof *edge_groups);
    pbw_index *point_groups = (pbw_index *)malloc((better->point_count + 1) * sizeof *point_groups);
    size_t i;
    int failed = edge_groups == NULL || point_groups == NULL ? fail(j, "out of memory") : 0;
    for (i = 0; !failed && i < better->edge_count && c->segment_groups != NULL; i++) {
        edge_groups[i] = c->segment_groups[better->edge_origins[i]];
    }
    for (i = 0; !failed && i < better->point_count && c->point_groups != NULL; i++) {
        point_groups[i] = better->original[i] == PBW_NONE ? PBW_NONE : c->point_groups[better->original[i]];
    }
    o->edges = better->edges;
    o->edge_count = better->edge_count;
    if (c->group_count > 0) {
        o->groups = c->groups;
        o->group_count = c->group_count;
        o->regions = better->regions;
        o->patches = better->patches;
        o->edge_groups = c->segment_groups != NULL ? edge_groups : NULL;
        o->point_groups = c->point_groups != NULL ? point_groups : NULL;
    }
    failed = failed ? failed : write_mesh(j);
    drop_groups(j);
    free(edge_groups);
    free(point_groups);
    return failed;
}

/* Segments that are no edges of tetrahedra are lost. */
static void warn_of_segments(const job *j, const pbw_tets *better)
{
    size_t i, lost = j->cloud.segment_count;
    for (i = 0; i < better->edge_count; i++) {       /* ascending; pieces of one follow each other */
        lost -= i == 0 || better->edge_origins[i] != better->edge_origins[i - 1];
    }
    if (lost > 0) {
        warn(j, "%s: %zu segment%s no edge of tetrahedra, or given twice, and left out", j->input, lost,
             lost == 1 ? " is" : "s are");
    }
}

/* ---- tetrahedra ---- */

static int improve_tets(job *j)
{
    pbw_improve_options how;
    pbw_improve_report report;
    pbw_tets in, better;
    pbw_status status;
    char why[128] = "";
    double start, *sizes = NULL;
    unsigned char *marks;
    int failed;
    memset(&how, 0, sizeof how);
    memset(&in, 0, sizeof in);
    how.target = number_of(j, "--target", 0);
    how.seconds = number_of(j, "--seconds", 0);
    how.feature_angle = number_of(j, "--feature-angle", 0);
    if (is_given(j, "--rounds") && !is_given(j, "--smooth")) {
        return complain("--rounds %s: it needs --smooth", text_of(j, "--rounds"));
    }
    if (is_given(j, "--smooth")) {
        how.smoother = (pbw_smoother)(PBW_SMOOTHER_LAPLACIAN - choice_of(j, "--smooth"));
        how.rounds = (int)number_of(j, "--rounds", 5);
        how.passes = is_given(j, "--only-smooth") ? -1 : 0;
    }
    in.points = j->cloud.points;
    in.point_count = j->cloud.count;
    in.corners = j->cloud.tetrahedra;
    in.tet_count = j->cloud.tetrahedron_count;
    failed = complete_groups(j);
    failed = failed ? failed : find_patches(j, in.corners, in.tet_count);
    failed = failed ? failed : make_sizes(j, &in, &sizes);
    marks = marks_of_groups(&j->cloud);
    if (failed || marks == NULL) {
        free(marks);
        free(sizes);
        return failed ? failed : fail(j, "out of memory");
    }
    in.regions = j->cloud.tetrahedron_groups;
    in.patches = j->patches;
    in.edges = j->cloud.segments;
    in.edge_count = j->cloud.segment_count;
    in.marks = marks;
    how.sizes = sizes;
    j->build.message = why;
    j->build.message_size = sizeof why;
    start = now();
    status = pbw_improve(&in, &how, &j->build, &better, &report);
    free(sizes);
    free(marks);
    j->build.message = NULL;
    if (status != PBW_OK) {
        return explain_file(j, status, why);
    }
    report_step(j, "improve", now() - start, "%zu %s, %zu point%s", better.tet_count,
                simplices(3, better.tet_count), COUNT(better.point_count));
    describe_quality(j, "before: ", &report.before);
    describe_quality(j, "after:  ", &report.after);
    describe_histogram(j, &report.after);
    if (is_given(j, "--quality")) {
        describe_measures(j, &better);
    }
    report_line(j, "volume %.12g, before %.12g", report.after.volume, report.before.volume);
    describe_moves(j, &report);
    warn_of_segments(j, &better);
    show_tets(j, &better);
    failed = write_better(j, &better);
    memset(&j->mesh, 0, sizeof j->mesh);
    pbw_tets_free(&better);
    return failed;
}

/* ---- triangles of the plane ---- */

static void describe_plane(const job *j, const char *when, const pbw_plane *plane)
{
    const pbw_plane_quality least = pbw_plane_quality_of(plane, PBW_PLANE_MIN_ANGLE);
    const pbw_plane_quality most = pbw_plane_quality_of(plane, PBW_PLANE_MAX_ANGLE);
    const pbw_plane_quality shape = pbw_plane_quality_of(plane, PBW_PLANE_SHAPE);
    report_line(j, "%sangles %.2f to %.2f degrees, least angle of a triangle in the mean %.2f; shape in the mean "
                "%.4f", when, least.least, most.most, least.mean, shape.mean);
}

void describe_mesh_quality(const job *j)
{
    if (j->mesh.dim == 3) {
        pbw_tets tets;
        pbw_quality quality;
        memset(&tets, 0, sizeof tets);
        tets.points = j->mesh.points;
        tets.point_count = j->mesh.point_count;
        tets.corners = j->mesh.simplices;
        tets.tet_count = j->mesh.simplex_count;
        if (pbw_tets_quality(&tets, &j->build, &quality)) {
            describe_quality(j, "", &quality);
            report_line(j, "volume %.12g", quality.volume);
        }
    } else {
        pbw_plane plane;
        memset(&plane, 0, sizeof plane);
        plane.points = j->mesh.points;
        plane.point_count = j->mesh.point_count;
        plane.triangles = j->mesh.simplices;
        plane.triangle_count = j->mesh.simplex_count;
        describe_plane(j, "", &plane);
    }
}

/* The better mesh, and what it carries.  view: the triangles of the input if points have values, else NULL. */
static pbw_status improve_plane(job *j, const plan *d, const pbw_plane *view, pbw_plane *plane, carried *c)
{
    void *own[2] = { NULL, NULL };
    const int way = choice_of(j, "--smooth");
    pbw_plane_options how;
    pbw_index *origin = NULL;
    pbw_status status;
    memset(&how, 0, sizeof how);
    how.build = &j->build;
    status = make_again(d, &how, plane);
    if (status == PBW_OK) {
        warn_of_losses(j, d, plane);
        status = list_groups(d, plane, own) ? PBW_OK : PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        status = smooth(d, plane, NULL, way < 0 ? PBW_PLANE_ODT : (pbw_plane_way)way,
                        (int)number_of(j, "--rounds", 5), &how);
    }
    if (status == PBW_OK) {
        status = find_origins(d, plane, NULL, &origin)
               ? carry(j, d, view, plane, origin, c)
               : PBW_ERROR_MEMORY;
    }
    free(origin);
    free(own[0]);
    free(own[1]);
    return status;
}

/* Writes the better mesh; groups are those of the input, if it has some. */
static int write_plane(job *j, const plan *d, const pbw_plane *plane, const carried *c)
{
    int failed;
    memset(&j->mesh, 0, sizeof j->mesh);
    j->mesh.dim = 2;
    j->mesh.points = plane->points;
    j->mesh.point_count = plane->point_count;
    j->mesh.simplices = plane->triangles;
    j->mesh.simplex_count = plane->triangle_count;
    j->mesh.neighbors = plane->neighbors;
    show_carried(&j->write, c, d->base);
    if (!d->has_groups) {
        drop_groups(j);
    }
    failed = write_mesh(j);
    memset(&j->mesh, 0, sizeof j->mesh);
    return failed;
}

static int improve_triangles(job *j)
{
    static const char *const of_tets[] = { "--target", "--seconds", "--feature-angle", "--size", "--error", NULL };
    pbw_plane plane, view;
    pbw_index *corners = NULL;
    pbw_status status = PBW_ERROR_MEMORY;
    carried c;
    plan d;
    const double start = now();
    int failed, carries, i;
    for (i = 0; of_tets[i] != NULL; i++) {
        if (is_given(j, of_tets[i])) {
            return complain("%s %s: it is for tetrahedra, %s has triangles", of_tets[i], text_of(j, of_tets[i]),
                            j->input);
        }
    }
    memset(&plane, 0, sizeof plane);
    memset(&c, 0, sizeof c);
    memset(&d, 0, sizeof d);
    failed = take_cloud(j, &d);
    carries = d.heights != NULL || d.column_count > 0;
    if (!failed && (!carries || unify_duplicates(j, &d)) && view_triangles(&d, &view, &corners)) {
        describe_plane(j, "before: ", &view);
        status = improve_plane(j, &d, carries ? &view : NULL, &plane, &c);
    }
    if (!failed && status != PBW_OK) {
        failed = status == PBW_CANCELLED ? stopped(j)
               : fail(j, "%s: %s", j->input, plane.what[0] != 0 ? plane.what : pbw_status_string(status));
    }
    if (!failed) {
        report_step(j, "improve", now() - start, "%zu triangle%s, %zu point%s", COUNT(plane.triangle_count),
                    COUNT(plane.point_count));
        describe_plane(j, "after:  ", &plane);
        if (is_given(j, "--quality")) {
            describe_plane_measures(j, &plane);
        }
        failed = write_plane(j, &d, &plane, &c);
    }
    carried_free(&c);
    pbw_plane_free(&plane);
    free(corners);
    domain_free(&d);
    return failed;
}

/* ---- the command ---- */

static int run(job *j)
{
    const int failed = load_sizes(j, "--size", 1);
    if (failed) {
        return failed;
    }
    if (j->cloud.dim == 2 && j->cloud.triangle_count > 0) {
        return improve_triangles(j);
    }
    return j->cloud.dim == 3 && j->cloud.tetrahedron_count > 0 ? improve_tets(j)
         : fail(j, "%s: it has no tetrahedra, and no triangles of one plane", j->input);
}

const command command_improve = {
    .name = "improve",
    .summary = "make the worst tetrahedra or triangles of a mesh better",
    .usage =
    "usage: pbw improve [options] mesh [-o output]...\n"
    "\n"
    "Makes the worst tetrahedra of a mesh better, until all dihedral angles reach the target or nothing helps.\n"
    "Points move, come and go; the boundary stays on the surface, its features stay as they are.\n"
    "Triangles of a plane become the Delaunay ones of their domain, which have the largest least angles, between\n"
    "rounds of --smooth; points of the boundary, of borders between regions and of groups with a name stay.\n"
    "Regions, groups of facets, edges and points stay what they are.\n"
    "\n"
    "input:   .msh .mesh .inp .su2 .vtu .vtk .ele with tetrahedra or with triangles of one z\n"
    "output:  .vtu .msh .msh2 .mesh .inp .su2 .node .ele .neigh .face (tetrahedra, boundary), .obj .ply .stl .off\n"
    "         (boundary), .svg (picture), .html (page to look around in); any number of them\n"
    "\n",
    .writes = "vtu msh msh2 mesh inp su2 node ele neigh face obj ply stl off svg html",
    .options = { improve_options, look_options, build_options, output_options, text_options, common_options, NULL },
    .run = run,
};
