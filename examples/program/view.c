/* view.c: pbw view. */
#include "program.h"

static const option view_options[] = {
    { "--points", NULL, "the points, not triangulated", SWITCH, 0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

int show_faces(job *j)
{
    const size_t n = j->cloud.count;
    size_t i;
    j->over = (double *)malloc((3 * n + 1) * sizeof *j->over);
    if (j->over == NULL) {
        return fail(j, "out of memory");
    }
    for (i = 0; i < n; i++) {
        memcpy(j->over + 2 * i, j->cloud.points + 3 * i, 2 * sizeof(double));
        j->over[2 * n + i] = j->cloud.points[3 * i + 2];
    }
    drop_groups(j);
    if (complete_groups(j) != 0) {
        return FAILURE;
    }
    if (j->cloud.triangle_groups != NULL) {
        j->write.groups = j->cloud.groups;
        j->write.group_count = j->cloud.group_count;
        j->write.regions = j->cloud.triangle_groups;
    }
    memset(&j->mesh, 0, sizeof j->mesh);
    j->mesh.dim = 2;
    j->mesh.points = j->over;
    j->mesh.point_count = n;
    j->mesh.simplices = j->cloud.triangles;
    j->mesh.simplex_count = j->cloud.triangle_count;
    return 0;
}

/* The simplices of a file; of too many tetrahedra for a page the boundary. */
static int show_simplices(job *j)
{
    mesh_faults faults;
    const int status = take_simplices(j, &faults);
    pbwio_cloud *cloud = &j->cloud;
    if (status != 0 || j->mesh.simplex_count <= PBWVIEW_MOST || j->mesh.dim == 2) {
        return status != 0 ? status : keep_groups(j);
    }
    warn(j, "%zu tetrahedra are too many for a browser: their boundary is shown", j->mesh.simplex_count);
    free(cloud->triangles);
    free(cloud->triangle_groups);
    cloud->triangle_groups = NULL;
    cloud->triangles = boundary_of(j, &cloud->triangle_count);
    return cloud->triangles != NULL ? show_faces(j) : fail(j, "out of memory");
}

/* The triangulation of the points; simplices outside a model are hidden at first. */
static int show_triangulation(job *j)
{
    int status = build(j);
    if (status == 0) {
        describe(j);
    }
    if (status == 0 && (is_given(j, "--inside") || (j->mesh.simplex_count > 0 && j->mesh.dim == 3
                                                    && j->cloud.triangle_count > 0))) {
        status = mark_inside(j);
        j->write.keep = j->picture.keep = is_given(j, "--inside") ? j->inside : NULL;
    }
    return status;
}

/* Refuses before the work what is too large for a page: of tetrahedra there are about 6.8 times as many as points. */
static int check_size(const job *j, int triangulated)
{
    const size_t each = !triangulated ? 1 : j->cloud.dim == 3 ? 7 : 2;
    if (j->cloud.count > PBWVIEW_MOST / each) {
        return fail(j, "%zu points%s are too much for a browser, which takes about %zu%s", j->cloud.count,
                    triangulated ? " with their triangulation" : "", PBWVIEW_MOST / each,
                    triangulated ? "; --points shows them without it" : "");
    }
    return 0;
}

static int run(job *j)
{
    const int by_points = is_given(j, "--retriangulate") || is_given(j, "--inside") || is_given(j, "--weights");
    int status = load(j, 1);
    status = status != 0 ? status : load_surface(j);
    if (status != 0) {
        return status;
    }
    if (is_given(j, "--points")) {
        status = check_size(j, 0);
        j->mesh.dim = j->cloud.dim;                                  /* borrowed, too */
        j->mesh.points = j->cloud.points;
        j->mesh.point_count = j->cloud.count;
    } else if (!by_points && has_simplices(j)) {
        status = show_simplices(j);
    } else if (!by_points && j->cloud.triangle_count > 0) {
        status = show_faces(j);
    } else {
        status = check_size(j, 1);
        status = status != 0 ? status : show_triangulation(j);
    }
    status = status != 0 ? status : write_mesh(j);
    if (status == 0) {
        report_line(j, "open this in a browser: %s", j->output[j->outputs - 1]);
    }
    return status;
}

const command command_view = {
    .name = "view",
    .summary = "make a page to look at",
    .usage =
    "usage: pbw view [options] input [-o page.html]\n"
    "\n"
    "Makes a page to look at a mesh, a surface or the triangulation of points in a browser: one file, no network.\n"
    "Of a file with tetrahedra or faces it shows these; of one with points alone, with --weights, --inside or\n"
    "--retriangulate, the triangulation of its points.\n"
    "\n"
    "input:   as for pbw mesh\n"
    "output:  .html; default: the name of the input with that ending; of that name, it replaces pages of pbw only\n"
    "\n",
    .writes = "html",
    .options = { view_options, file_mesh_options, inside_options, look_options, input_options, weight_options,
                 build_options, output_options, common_options, NULL },
    .run = run,
    .names_output = 1,
    .may_be_flat = 1,
};
