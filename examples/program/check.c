/* check.c: pbw check. */
#include "program.h"

static int run(job *j)
{
    int status, closed = 1;
    if (is_pbwt(j)) {
        return check_pbwt(j);
    }
    status = load(j, 1);
    if (status == 0 && !is_given(j, "--retriangulate")) {
        if (has_simplices(j)) {
            return check_simplices(j);
        }
        if (j->cloud.triangle_count > 0) {
            return describe_surface(j, &j->cloud, 1) ? 0 : fail(j, "the surface has faults");
        }
    }
    if (status == 0 && j->cloud.triangle_count > 0 && j->cloud.dim == 3) {
        closed = describe_surface(j, &j->cloud, 1);
    }
    status = status != 0 ? status : build(j);
    status = status != 0 ? status : check(j);
    if (status == 0) {
        describe(j);
    }
    return status != 0 ? status : closed ? 0 : fail(j, "the surface has faults");
}

const command command_check = {
    .name = "check",
    .summary = "find faults in a model and its triangulation",
    .usage =
    "usage: pbw check [options] input\n"
    "\n"
    "Tells what is wrong and where, with exit status 1.  Of a mesh: simplices without volume, facets of more than\n"
    "two simplices or of two on one side, and the boundary; it tells angles, and whether the mesh is Delaunay.\n"
    "Of a surface: edges of one face are open, of more than two crowded, turned where two faces run alike.\n"
    "Of points, or with --retriangulate: proves their triangulation.  Points, simplices, faces are counted from 0.\n"
    "Of a .pbwt file the triangulation is proved tile by tile, links across tiles and the hull with it.\n"
    "\n",
    .options = { file_mesh_options, input_options, weight_options, build_options, common_options, NULL },
    .run = run,
};
