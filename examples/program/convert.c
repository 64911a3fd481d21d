/* convert.c: pbw convert. */
#include "program.h"

static int run(job *j)
{
    pbwmodel_content content;
    pbwio_cloud found;
    double *normals = NULL;
    size_t i;
    int failed;
    if (j->outputs == 0) {
        return complain("an output is needed; see pbw convert --help");
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
    "input:   as for pbw mesh\n"
    "output:  .obj .ply .off .stl with faces, .xyz .csv without\n"
    "\n",
    "obj ply off stl xyz csv txt pts asc dat tsv",
    { input_options, output_options, text_options, common_options, NULL, NULL, NULL, NULL },
    run, 0, 1, 0, NULL, 0
};
