/* check.c: pbw check. */
#include "program.h"

static int run(job *j)
{
    int status, closed = 1;
    if (is_pbwt(j)) {
        return check_pbwt(j);
    }
    status = load(j, 1);
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
    "check", "find faults in a model and its triangulation",
    "usage: pbw check [options] input\n"
    "\n"
    "Tells what is wrong with a model's surface and where, and proves the triangulation of its points.\n"
    "The exit status is 1 if edges are open, crowded or turned, or the triangulation is wrong.\n"
    "An edge of one face is open, one of more than two crowded, one along which two faces run alike turned.\n"
    "Points and faces are counted from 0.\n"
    "Of a .pbwt file the triangulation is proved tile by tile, links across tiles and the hull with it.\n"
    "\n",
    NULL,
    { input_options, weight_options, build_options, common_options, NULL, NULL, NULL, NULL, NULL },
    run, 0, 0, 0, NULL, 0
};
