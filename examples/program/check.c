/* check.c: pbw check. */
#include "program.h"

static int run(job *j)
{
    int status, closed = 1;
    if (is_pbwt(j)) {
        return j->outputs > 0 ? complain("-o is for the faults of surfaces") : check_pbwt(j);
    }
    status = load(j, 1);
    if (status == 0 && !is_given(j, "--retriangulate") && !has_simplices(j) && j->cloud.triangle_count > 0) {
        return check_faces(j);
    }
    if (status == 0 && j->outputs > 0) {
        return fail(j, "-o is for the faults of surfaces, and this is none");
    }
    if (status == 0 && !is_given(j, "--retriangulate") && has_simplices(j)) {
        return check_simplices(j);
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
    "usage: pbw check [options] input [-o faults]...\n"
    "\n"
    "Tells what is wrong and where, with exit status 1.  Of a mesh: simplices without volume, facets of more than\n"
    "two simplices or of two on one side, and the boundary; it tells angles, and whether the mesh is Delaunay.\n"
    "Of a surface: edges of one face are open, of more than two crowded, turned where two faces run alike; pairs of\n"
    "faces that meet, exactly, elsewhere than in common corners and edges; faces without area, and given again.\n"
    "Of points, or with --retriangulate: proves their triangulation.  Points, simplices, faces are counted from 0.\n"
    "Of a .pbwt file the triangulation is proved tile by tile, links across tiles and the hull with it.\n"
    "\n"
    "output:  the faults of a surface: .vtu .obj, its faces in groups by fault, with faulty edges and the lines in\n"
    "         which faces meet; .csv, a table with places; .html, a page that shows them on the model\n"
    "\n",
    .writes = "vtu obj csv html",
    .options = { file_mesh_options, input_options, weight_options, build_options, output_options, text_options,
                 common_options, NULL },
    .run = run,
};
