/* mesh.c: pbw mesh. */
#include "program.h"

static const option mesh_options[] = {
    { "--any-order", NULL, "skip the canonical order of simplices", SWITCH, 0, 0, NULL },
    { "--no-check", NULL, "skip the exact check of the result", SWITCH, 0, 0, NULL },
    { "--no-orphans", NULL, "leave points that are corners of nothing out of the output", SWITCH, 0, 0, NULL },
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
        j->write.keep = j->picture.keep = j->inside;
    }
    if (status == 0) {
        carry_columns(j);
    }
    return status != 0 ? status : write_mesh(j);
}

const command command_mesh = {
    "mesh", "triangulate points; also without its name",
    "usage: pbw [mesh] [options] input [-o output]...\n"
    "\n"
    "Exact Delaunay triangulation of the points of a file, or with --weights the regular one.\n"
    "\n"
    "input:   .obj .ply .stl .off .node .ele .msh .mesh .vtu .vtk .json .geojson, tables (.xyz .csv .txt ...),\n"
    "         molecules (.xyz), and all these with .gz; - is the standard input\n"
    "output:  .vtu .msh .msh2 .mesh .inp .su2 .node .ele .neigh .face .edge (simplices, boundary),\n"
    "         .obj .ply .stl .off (hull), .xyz .csv (points), .svg (picture), .html (page to look around\n"
    "         in), .geojson (triangles of the plane); any number of them\n"
    "\n",
    "vtu msh msh2 mesh inp su2 node ele neigh face edge obj ply stl off xyz csv txt pts asc dat tsv svg html geojson",
    { mesh_options, look_options, input_options, weight_options, build_options, output_options, text_options,
      common_options, NULL },
    run, 0, 0, 0, NULL, 0
};
