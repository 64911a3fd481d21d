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

static int writes_simplices(const char *ending)
{
    return strstr(" vtu msh msh2 mesh inp su2 node ele neigh face edge ", ending) != NULL;
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
        return pbwio_save(path, emit_rows, &j->cloud, error);
    }
    snprintf(name, sizeof name, "a.%s", ending);
    content->format = j->write.format = pbwio_format_of(name);
    return writes_simplices(ending) ? pbwio_write(path, &j->mesh, &j->write, error)
                                    : pbwmodel_write(path, content, j->write.flags, error);
}

static int run(job *j)
{
    pbwmodel_content content;
    pbwio_cloud found;
    mesh_faults faults;
    double *normals = NULL;
    size_t i;
    int failed, k, of_simplices = 0;
    if (j->outputs == 0) {
        return complain("an output is needed; see pbw convert --help");
    }
    if (is_pbwt(j)) {
        return is_given(j, "--tile") ? convert_tile(j) : complain("--tile is needed: which tile of %s", j->input);
    }
    for (k = 0; k < j->outputs; k++) {
        of_simplices |= writes_simplices(ending_of(j, j->output[k]));
    }
    failed = load(j, of_simplices);
    if (failed) {
        return failed;
    }
    if (of_simplices && !has_simplices(j)) {
        return fail(j, "%s: it has no tetrahedra, and no triangles of one plane; pbw mesh makes them of its points",
                    j->input != NULL ? j->input : "what is generated");
    }
    failed = of_simplices ? take_simplices(j, &faults) : 0;
    if (failed) {
        return failed;
    }
    memset(&found, 0, sizeof found);
    memset(&content, 0, sizeof content);
    content.dim = j->cloud.dim;
    content.points = j->cloud.points;
    content.point_count = j->cloud.count;
    content.triangles = j->cloud.triangles;
    content.triangle_count = j->cloud.triangle_count;
    if (j->input != NULL && pbwmodel_read_normals(j->input, &j->cloud, &found)) {
        normals = (double *)calloc(j->cloud.count, 3 * sizeof *normals);
        for (i = 0; normals != NULL && i < 3 * j->cloud.triangle_count; i++) {     /* one a point: the last */
            memcpy(normals + 3 * (size_t)j->cloud.triangles[i],
                   found.points + 3 * (size_t)found.triangles[i], 3 * sizeof *normals);
        }
        content.normals = j->cloud.triangle_count > 0 ? normals : found.points;
    }
    failed = write_with(j, write_one, &content);
    free(normals);
    pbwio_free(&found);
    return failed;
}

const command command_convert = {
    "convert", "from one format to another",
    "usage: pbw convert [options] input output...\n"
    "\n"
    "Points, normals, faces and simplices from one format to another; simplices are turned positive.\n"
    "\n"
    "input:   as for pbw mesh; or .pbwt, and --tile: its simplices, as a mesh\n"
    "output:  .obj .ply .off .stl with faces, .xyz .csv without; .bin, doubles for pbw tiles, with\n"
    "         --weights w: and a weight; of tetrahedra, of triangles in the plane and of a tile also .vtu .msh .msh2\n"
    "         .mesh .inp .su2 .node .ele .neigh .face .edge\n"
    "\n",
    "obj ply off stl xyz bin csv txt pts asc dat tsv vtu msh msh2 mesh inp su2 node ele neigh face edge",
    { tile_options, input_options, weight_options, output_options, text_options, common_options, NULL, NULL },
    run, 0, 1, 0, NULL, 0
};
