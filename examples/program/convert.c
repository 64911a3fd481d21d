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

static int run(job *j)
{
    pbwmodel_content content;
    pbwio_cloud found;
    double *normals = NULL;
    size_t i;
    int failed, k;
    if (j->outputs == 0) {
        return complain("an output is needed; see pbw convert --help");
    }
    if (is_pbwt(j)) {
        return is_given(j, "--tile") ? convert_tile(j) : complain("--tile is needed: which tile of %s", j->input);
    }
    for (k = 0; k < j->outputs; k++) {
        const char *ending = ending_of(j, j->output[k]);
        if (strcmp(ending, "vtu") == 0 || strcmp(ending, "msh") == 0 || strcmp(ending, "mesh") == 0) {
            return complain("-o %s: of a tile only; pbw mesh writes that", j->output[k]);
        }
    }
    failed = load(j, 0);
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
    failed = write_model(j, &content);
    free(normals);
    pbwio_free(&found);
    return failed;
}

const command command_convert = {
    "convert", "from one format to another",
    "usage: pbw convert [options] input output...\n"
    "\n"
    "Points, normals and faces from one format to another.\n"
    "\n"
    "input:   as for pbw mesh; or .pbwt, and --tile: its simplices, as a mesh\n"
    "output:  .obj .ply .off .stl with faces, .xyz .csv without; of a tile also .vtu .msh .mesh\n"
    "\n",
    "obj ply off stl xyz csv txt pts asc dat tsv vtu msh mesh",
    { tile_options, input_options, output_options, text_options, common_options, NULL, NULL, NULL },
    run, 0, 1, 0, NULL, 0
};
