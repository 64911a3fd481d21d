/* view.c: pbw view. */
#include "program.h"

static const option view_options[] = {
    { "--points", NULL, "the points, not triangulated", SWITCH, 0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

static int run(job *j)
{
    int status = load(j, 1);
    status = status != 0 ? status : load_surface(j);
    if (status == 0 && is_given(j, "--points")) {
        j->mesh.dim = j->cloud.dim;                                  /* borrowed: nothing in it is pbw_free's */
        j->mesh.points = j->cloud.points;
        j->mesh.point_count = j->cloud.count;
    } else if (status == 0) {
        status = build(j);
        if (status == 0) {
            describe(j);
        }
        if (status == 0 && (is_given(j, "--inside") || (j->mesh.simplex_count > 0 && j->mesh.dim == 3
                                                        && j->cloud.triangle_count > 0))) {
            status = mark_inside(j);                                 /* of models not asked for: hidden at first */
            j->write.keep = j->picture.keep = is_given(j, "--inside") ? j->inside : NULL;
        }
    }
    status = status != 0 ? status : write_mesh(j);
    if (status == 0) {
        note(j, "open this in a browser: %s", j->output[j->outputs - 1]);
    }
    return status;
}

const command command_view = {
    "view", "make a page to look at",
    "usage: pbw view [options] input [-o page.html]\n"
    "\n"
    "Makes a page to look at the triangulation of the points of a file in a browser: one file, no network.\n"
    "\n"
    "input:   as for pbw mesh\n"
    "output:  .html; default: the name of the input with that ending; of that name, it replaces pages of pbw only\n"
    "\n",
    "html",
    { view_options, look_options, input_options, weight_options, build_options, output_options, common_options,
      NULL },
    run, 0, 0, 1, NULL, 1
};
