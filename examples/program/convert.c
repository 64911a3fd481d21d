/* convert.c: pbw convert. */
#include "program.h"
#include "pbw_tilefile.h"

static const option tile_options[] = {
    { "--tile", "N", "of a .pbwt file: which tile, from 0", WHOLE, 0, 65536, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

static pbwio_status write_tile(job *j, const char *path, const char *ending, void *user, pbwio_error *error)
{
    pbwio_output output = j->write;
    (void)ending;
    output.flags |= PBWIO_NO_ORPHANS;
    return pbwio_write(path, (const pbw_mesh *)user, &output, error);
}

static int convert_tile(job *j)
{
    pbw_mesh mesh;
    int failed = convert_pbwt(j, &mesh);
    if (!failed) {
        failed = write_with(j, write_tile, &mesh);
        pbwtf_mesh_free(&mesh);
    }
    return failed;
}

static int is_one_of(const char *list, const char *ending)      /* blanks around each */
{
    char word[16];
    snprintf(word, sizeof word, " %s ", ending);
    return strstr(list, word) != NULL;
}

/* Whether an output is of the simplices of the file: also where their boundary is all that it has of a surface. */
static int is_of_simplices(const job *j, const char *ending)
{
    return has_simplices(j) && (is_one_of(" vtu msh msh2 mesh inp su2 node ele neigh face edge ", ending)
                                || (j->cloud.triangle_count == 0 && is_one_of(" obj ply stl off ", ending)));
}

/* Doubles x y (z) (weight) of each point, as pbw tiles reads them piece by piece. */
static void emit_rows(void *user, FILE *file)
{
    const pbwio_cloud *c = (const pbwio_cloud *)user;
    const size_t dim = (size_t)c->dim;
    size_t i;
    for (i = 0; i < c->count; i++) {
        fwrite(c->points + i * dim, sizeof *c->points, dim, file);
        if (c->weights != NULL) {
            fwrite(c->weights + i, sizeof *c->weights, 1, file);
        }
    }
}

/* One output: the mesh of the file, or its points and faces. */
static pbwio_status write_one(job *j, const char *path, const char *ending, void *user, pbwio_error *error)
{
    pbwmodel_content *content = (pbwmodel_content *)user;
    char name[16];
    if (strcmp(ending, "bin") == 0) {
        return pbwio_save(path, emit_rows, &j->cloud, &j->build, error);
    }
    snprintf(name, sizeof name, "a.%s", ending);
    content->format = j->write.format = pbwio_format_of(name);
    return is_of_simplices(j, ending) ? pbwio_write(path, &j->mesh, &j->write, error)
                                      : pbwmodel_write(path, content, j->write.flags, error);
}

void fill_surface(const job *j, pbwmodel_content *content, pbwio_output *output)
{
    const pbwio_cloud *c = &j->cloud;
    *output = j->write;
    content->dim = c->dim;
    content->points = c->points;
    content->point_count = c->count;
    content->triangles = c->triangles;
    content->triangle_count = c->triangle_count;
    content->weights = c->weights;
    content->output = output;
    output->groups = c->group_count > 0 ? c->groups : NULL;
    output->group_count = c->group_count;
    output->regions = c->triangle_groups;
    output->edges = c->dim == 3 ? c->segments : NULL;
    output->edge_count = c->dim == 3 ? c->segment_count : 0;
    output->edge_groups = c->segment_groups;
    output->point_groups = c->point_groups;
    output->columns = c->columns;
    output->column_count = c->column_count;
    output->heights = c->heights;
}

/* Normals, one a point: of points with several the last one; the caller frees them.  NULL: there are none. */
static double *find_normals(const job *j)
{
    pbwio_cloud found;
    double *normals = NULL;
    size_t i;
    memset(&found, 0, sizeof found);
    if (j->input != NULL && pbwmodel_read_normals(j->input, &j->cloud, &found)) {
        normals = (double *)calloc(j->cloud.count + 1, 3 * sizeof *normals);
        for (i = 0; normals != NULL && i < 3 * j->cloud.triangle_count; i++) {
            memcpy(normals + 3 * (size_t)j->cloud.triangles[i], found.points + 3 * (size_t)found.triangles[i],
                   3 * sizeof *normals);
        }
        if (normals != NULL && j->cloud.triangle_count == 0) {
            memcpy(normals, found.points, 3 * j->cloud.count * sizeof *normals);
        }
    }
    pbwio_free(&found);
    return normals;
}

static int run(job *j)
{
    pbwmodel_content content;
    pbwio_output surface;
    mesh_faults faults;
    double *normals;
    int failed, k, flat = 0, of_simplices = 0, solvers = 0;
    if (j->outputs == 0) {
        return complain("an output is needed; see pbw convert --help");
    }
    if (is_pbwt(j)) {
        return is_given(j, "--tile") ? convert_tile(j) : complain("--tile is needed: which tile of %s", j->input);
    }
    for (k = 0; k < j->outputs; k++) {
        flat |= is_one_of(" vtu msh msh2 mesh inp su2 node ele neigh face edge ", ending_of(j, j->output[k]));
        solvers |= is_one_of(" su2 node ele neigh face edge ", ending_of(j, j->output[k]));
    }
    failed = load(j, flat);
    for (k = 0; k < j->outputs && !failed; k++) {
        of_simplices |= is_of_simplices(j, ending_of(j, j->output[k]));
    }
    if (!failed && flat && !of_simplices && (solvers || j->cloud.triangle_count == 0)) {
        return fail(j, "%s: it has no tetrahedra, and no triangles of one plane; pbw mesh makes them of its points",
                    j->input != NULL ? j->input : "what is generated");
    }
    failed = failed ? failed : of_simplices ? take_simplices(j, &faults) : 0;
    if (failed) {
        return failed;
    }
    memset(&content, 0, sizeof content);
    if (complete_groups(j) != 0) {
        return FAILURE;
    }
    fill_surface(j, &content, &surface);
    if (!of_simplices) {
        j->write = surface;
        j->mesh.dim = content.dim;
        j->mesh.points = content.points;
        j->mesh.point_count = content.point_count;
        j->mesh.simplices = content.triangles;
        j->mesh.simplex_count = content.triangle_count;
    }
    j->mesh.weights = j->cloud.weights;
    content.normals = normals = find_normals(j);
    failed = write_with(j, write_one, &content);
    free(normals);
    return failed;
}

const command command_convert = {
    .name = "convert",
    .summary = "from one format to another",
    .usage =
    "usage: pbw convert [options] input output...\n"
    "\n"
    "Points, normals, faces and simplices from one format to another; simplices are turned positive.\n"
    "\n"
    "input:   as for pbw mesh; or .pbwt, and --tile: its simplices, as a mesh\n"
    "output:  .obj .ply .off .stl .vtu .msh .msh2 .mesh .inp with faces or simplices, .xyz .csv without; of\n"
    "         tetrahedra, of triangles in the plane and of a tile also .su2 .node .ele .neigh .face .edge; .bin,\n"
    "         doubles for pbw tiles, with --weights w: and a weight\n"
    "\n",
    .writes = "obj ply off stl xyz bin csv txt pts asc dat tsv vtu msh msh2 mesh inp su2 node ele neigh face edge",
    .options = { tile_options, input_options, weight_options, output_options, text_options, common_options, NULL },
    .run = run,
    .outputs_follow = 1,
};
