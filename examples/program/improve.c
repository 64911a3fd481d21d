/* improve.c: pbw improve. */
#include "program.h"

static const option improve_options[] = {
    { "--target", "DEGREES", "dihedral angles from this to 180 less this; default 30", WHOLE, 1, 60, NULL },
    { "--seconds", "S", "end after that time with what is reached", POSITIVE, 0, 0, NULL },
    { "--feature-angle", "DEGREES", "edges of the boundary that bend by more stay; default 40", WHOLE, 1, 180, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

void describe_quality(const job *j, const char *when, const pbw_quality *q)
{
    note(j, "%sdihedral angles %.2f, %.2f (0.1 %%), %.2f (1 %%) to %.2f degrees; "
         "below 5, 10, 20, 30: %zu, %zu, %zu, %zu", when, q->least, q->permille, q->percent, q->largest, q->below[0],
         q->below[1], q->below[2], q->below[3]);
}

void describe_histogram(const job *j, const pbw_quality *q)
{
    char line[256];
    size_t i, used = 0;
    for (i = 0; i < 18; i++) {
        used += (size_t)snprintf(line + used, sizeof line - used, " %zu", q->bins[i]);
    }
    note(j, "angles in each 10 degrees:%s", line);
}

/* The writers' view of tetrahedra. */
void show_tets(job *j, const pbw_tets *tets)
{
    memset(&j->mesh, 0, sizeof j->mesh);
    j->mesh.dim = 3;
    j->mesh.points = tets->points;
    j->mesh.point_count = tets->point_count;
    j->mesh.simplices = tets->corners;
    j->mesh.simplex_count = tets->tet_count;
    j->mesh.neighbors = tets->neighbors;
}

static void describe_moves(const job *j, const pbw_improve_report *r)
{
    note(j, "%zu edges removed, %zu of the boundary; %zu points moved, %zu on the boundary; %zu peeled off, "
         "%zu flips, %zu contractions, %zu insertions; %d passes", r->removals + r->boundary_removals,
         r->boundary_removals, r->smoothings + r->slides, r->slides, r->peelings, r->flips, r->contractions,
         r->insertions, r->passes);
    if (r->left > 0) {
        note(j, "below the target in the end: %zu", r->left);
    }
}

static int run(job *j)
{
    pbw_improve_options how;
    pbw_improve_report report;
    pbw_tets in, better;
    pbw_status status;
    char why[128] = "";
    double start;
    int failed = load(j, 0);
    if (failed) {
        return failed;
    }
    if (j->cloud.dim != 3 || j->cloud.tetrahedron_count == 0) {
        return fail(j, "%s: it has no tetrahedra", j->input);
    }
    memset(&how, 0, sizeof how);
    memset(&in, 0, sizeof in);
    how.target = number_of(j, "--target", 0);
    how.seconds = number_of(j, "--seconds", 0);
    how.feature_angle = number_of(j, "--feature-angle", 0);
    in.points = j->cloud.points;
    in.point_count = j->cloud.count;
    in.corners = j->cloud.tetrahedra;
    in.tet_count = j->cloud.tetrahedron_count;
    j->build.message = why;
    j->build.message_size = sizeof why;
    start = now();
    status = pbw_improve(&in, &how, &j->build, &better, &report);
    j->build.message = NULL;
    if (status != PBW_OK) {
        return status == PBW_CANCELLED ? stopped(j)
             : fail(j, "%s: %s", j->input, *why != 0 ? why : pbw_status_string(status));
    }
    say(j, "improve", now() - start, "%zu tetrahedra, %zu points", better.tet_count, better.point_count);
    describe_quality(j, "before: ", &report.before);
    describe_quality(j, "after:  ", &report.after);
    describe_histogram(j, &report.after);
    note(j, "volume %.12g, before %.12g", report.after.volume, report.before.volume);
    describe_moves(j, &report);
    show_tets(j, &better);
    failed = write_mesh(j);
    memset(&j->mesh, 0, sizeof j->mesh);
    pbw_tets_free(&better);
    return failed;
}

const command command_improve = {
    "improve", "make the worst tetrahedra of a mesh better",
    "usage: pbw improve [options] mesh [-o output]...\n"
    "\n"
    "Makes the worst tetrahedra of a mesh better, until all dihedral angles reach the target or nothing helps.\n"
    "Points move, come and go; the boundary stays on the surface, its features stay as they are.\n"
    "\n"
    "input:   .msh .mesh .vtu .ele with tetrahedra\n"
    "output:  .vtu .msh .msh2 .mesh .inp .su2 .node .ele .neigh .face (tetrahedra, boundary), .obj .ply .stl .off\n"
    "         (boundary), .html (page to look around in); any number of them\n"
    "\n",
    "vtu msh msh2 mesh inp su2 node ele neigh face obj ply stl off html",
    { improve_options, output_options, text_options, common_options, NULL, NULL, NULL, NULL },
    run, 0, 0, 0, NULL, 0
};
