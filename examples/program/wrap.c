/* wrap.c: pbw wrap.
   In: triangles, segments and points, perhaps in groups.  Out: a closed surface around them, with the groups of the
   nearest triangles, the tetrahedra inside of it, and a report. */
#include "program.h"

const option wrapping_options[] = {
    OPTION_ALPHA("of wraps: radius of a ball that does not pass, so that holes and gaps below twice that\n"
                 "are closed: a number, a formula or a column, as --size; default: 1/50 of the diagonal,\n"
                 "of solids half the size", FORMULA),
    { "--offset", "D", "of wraps: distance of points from the model; default: 1/30 of alpha, of solids 1/8\n"
      "of the size, so that sheets become plates that have room for good tetrahedra; without it,\n"
      "points of a solid are pulled onto a closed model", POSITIVE, 0, 0, NULL },
    { "--cavities", "FILE", "of wraps: points; cavities with one of them are carved from inside, too", PLAIN, 0, 0,
      NULL },
    { "--all-points", NULL, "wraps points that are corners of nothing, too", SWITCH, 0, 0, NULL },
    { "--fast", NULL, "wraps in half the time, with up to a quarter more facets", SWITCH, 0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

static const option wrap_options[] = {
    OPTION_MOST("tetrahedra"),
    OPTION_SECONDS,
    OPTION_QUALITY,
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

/* ---- the input ---- */

typedef struct elements {
    pbw_wrap_input in;
    pbw_index *boundary, *singles;                   /* of tetrahedra; points that are corners of nothing */
} elements;

/* Lists points that are corners of nothing, if they are wanted or all there is. */
static int list_points(const job *j, elements *e)
{
    const size_t count = j->cloud.count;
    const int wanted = e->in.triangle_count + e->in.segment_count == 0 || is_given(j, "--all-points");
    unsigned char *used = (unsigned char *)calloc(count + 1, 1);
    size_t i, left = 0;
    e->singles = (pbw_index *)malloc((count + 1) * sizeof *e->singles);
    if (used == NULL || e->singles == NULL) {
        free(used);
        return fail(j, "out of memory");
    }
    for (i = 0; i < 3 * e->in.triangle_count; i++) {
        used[e->in.triangles[i]] = 1;
    }
    for (i = 0; i < 2 * e->in.segment_count; i++) {
        used[e->in.segments[i]] = 1;
    }
    for (i = 0; i < 4 * j->cloud.tetrahedron_count; i++) {
        used[j->cloud.tetrahedra[i]] = 1;
    }
    for (i = 0; i < count; i++) {
        if (!used[i]) {
            e->singles[left++] = (pbw_index)i;
        }
    }
    free(used);
    e->in.singles = e->singles;
    e->in.single_count = wanted ? left : 0;
    if (!wanted && left > 0) {
        warn(j, "%s: %zu point%s of no face or segment %s left out; --all-points wraps %s, too", j->input,
             COUNT(left), left == 1 ? "is" : "are", left == 1 ? "it" : "them");
    }
    return 0;
}

/* The triangles and segments of the file, of tetrahedra their boundary. */
static int find_elements(job *j, elements *e)
{
    const pbwio_cloud *c = &j->cloud;
    mesh_faults faults;
    memset(e, 0, sizeof *e);
    e->in.points = c->points;
    e->in.point_count = c->count;
    e->in.triangles = c->triangles;
    e->in.triangle_count = c->triangle_count;
    e->in.segments = c->segments;
    e->in.segment_count = c->segment_count;
    if (c->tetrahedron_count > 0) {
        const int failed = take_simplices(j, &faults);
        if (failed) {
            return failed;
        }
        e->boundary = boundary_of(j, &e->in.triangle_count);
        e->in.triangles = e->boundary;
        if (e->boundary == NULL) {
            return fail(j, "out of memory");
        }
        if (c->tetrahedron_groups != NULL) {
            warn(j, "%s: a wrap is one region: those of its tetrahedra are not kept", j->input);
        }
        if (c->triangle_count > 0) {
            warn(j, "%s: it has tetrahedra: their boundary is wrapped, and not its %zu face%s", j->input,
                 COUNT(c->triangle_count));
        }
    }
    return list_points(j, e);
}

static int load_seeds(job *j, pbwio_cloud *seeds, pbw_wrap_options *how)
{
    pbwio_options read = j->read;
    pbwio_error error;
    pbwio_status status;
    const char *path = text_of(j, "--cavities");
    if (path == NULL) {
        return 0;
    }
    read.columns = read.weight = read.keep = NULL;
    status = pbwio_read(path, &read, seeds, &error);
    how->seeds = seeds->points;
    how->seed_count = seeds->count;
    return status == PBWIO_OK ? 0 : explain_io(j, status, &error);
}

/* ---- the report ---- */

static int refuse(const job *j, pbw_status status, const pbw_wrap_report *r)
{
    switch (r->refusal) {
    case PBW_WRAP_EMPTY:
        return fail(j, "%s: it has nothing to wrap", j->input);
    case PBW_WRAP_NO_SIZE:
        return fail(j, "%s: all of it is at one place; --alpha says how large the wrap shall be", j->input);
    case PBW_WRAP_NEAR:
        return fail(j, "%s: the offset %.3g is below 1e-9 of its largest coordinate; a larger --offset will do, or "
                    "the model nearer to the origin", j->input, r->offset);
    case PBW_WRAP_LATE:
        return fail(j, "%s: --seconds were over before there was a wrap; a larger --alpha needs less time", j->input);
    case PBW_WRAP_LARGE:
        return fail(j, "%s: more tetrahedra than --most allows; a larger --alpha needs fewer", j->input);
    default:
        return explain_file(j, status, "");
    }
}

/* Reports on a wrap of so many facets, points and tetrahedra. */
static void report_on(const job *j, const pbw_wrap_report *r, size_t facets, size_t points, size_t tets)
{
    report_step(j, "tree", r->seconds[0], "%s", "");
    report_step(j, "wrap", r->seconds[1], "alpha %.6g, offset %.6g, %zu round%s", r->alpha, r->offset,
                COUNT(r->rounds));
    report_line(j, "%zu facet%s in %zu component%s, %zu point%s; %zu %s inside; "
                "%.0f facets a second of processor time", COUNT(facets), COUNT(r->components), COUNT(points), tets,
                simplices(3, tets), r->seconds[1] > 0 ? (double)facets / r->seconds[1] : 0);
    report_line(j, "volume %.9g, area %.9g", r->volume, r->area);
    if (r->repairs > 0) {
        report_line(j, "%zu tetrahedr%s put back for a manifold", r->repairs, r->repairs == 1 ? "on" : "a");
    }
    if (r->unused_seeds > 0) {
        warn(j, "%zu seed%s nearer to the model than alpha, or outside of its box: they have no effect",
             r->unused_seeds, r->unused_seeds == 1 ? " is" : "s are");
    }
    if (r->shell) {
        char remedy[80];
        snprintf(remedy, sizeof remedy, r->closing > 0 ? "--alpha %.3g closes it"
                 : is_given(j, "--seconds") || is_given(j, "--alpha") ? "a larger --alpha may close it"
                 : "no --alpha closes it", r->closing);
        warn(j, "%.0f %% of the wrap is a thin shell around %s; %s", 100 * r->both_sides,
             j->cloud.triangle_count + j->cloud.tetrahedron_count > 0 ? "both sides of the model, which is open"
             : "points or segments alone", remedy);
    }
}

static void report_distances(const job *j, const char *when, const double distance[2], double size)
{
    if (distance[0] >= 0) {
        report_line(j, "%sthe boundary is up to %.3f sizes of %.6g from the model, the model up to %.3f sizes from "
                    "the boundary", when, distance[0] / size, size, distance[1] / size);
    }
}

static void report_on_solid(const job *j, const pbw_tets *made, const pbw_wrap_solid_report *r)
{
    if (r->raised > 0) {
        warn(j, "the model is open, and alpha %.3g makes a thin shell: %.3g, which closes it, is taken instead",
             r->raised, r->wrap.alpha);
    }
    report_on(j, &r->wrap, r->facets, r->points, r->tets);
    report_distances(j, "before: ", r->before, r->size);
    report_step(j, "improve", r->seconds[0], "%d pass%s", r->improve.passes, r->improve.passes == 1 ? "" : "es");
    report_line(j, "%zu %s, %zu point%s", made->tet_count, simplices(3, made->tet_count), COUNT(made->point_count));
    describe_quality(j, "before: ", &r->improve.before);
    describe_quality(j, "after:  ", &r->improve.after);
    describe_histogram(j, &r->improve.after);
    report_distances(j, "after:  ", r->after, r->size);
    if (r->late) {
        warn(j, "--seconds were over: improvement ended with %zu %s below the target, and distances are not measured",
             r->improve.left, simplices(3, r->improve.left));
    } else if (r->after[0] < 0) {
        warn(j, "--seconds were over: distances are not measured");
    }
}

/* ---- the output ---- */

/* The groups of the nearest triangles, as patches of the facets. */
static int name_patches(job *j, const elements *e, const pbw_tets *tets)
{
    const pbwio_cloud *c = &j->cloud;
    pbw_surface surface;
    size_t i, k;
    int failed;
    if (c->triangle_groups == NULL || e->boundary != NULL) {
        return 0;
    }
    failed = explain(j, pbw_surface_create(c->points, c->count, c->triangles, c->triangle_count, &j->build,
                                           &surface));
    j->patches = (pbw_index *)malloc((4 * tets->tet_count + 1) * sizeof *j->patches);
    if (!failed && j->patches == NULL) {
        failed = fail(j, "out of memory");
    }
    for (i = 0; i < 4 * tets->tet_count && !failed; i++) {
        double middle[3] = { 0, 0, 0 }, place[3];
        j->patches[i] = PBW_NONE;
        for (k = 0; k < 12 && tets->neighbors[i] == PBW_NONE; k++) {
            const pbw_index p = tets->corners[i / 4 * 4 + k / 3];
            middle[k % 3] += k / 3 == i % 4 ? 0 : tets->points[3 * (size_t)p + k % 3] / 3;
        }
        if (tets->neighbors[i] == PBW_NONE) {
            j->patches[i] = c->triangle_groups[pbw_surface_closest(&surface, middle, HUGE_VAL, place)];
        }
    }
    pbw_surface_free(&surface);
    j->write.patches = j->patches;
    j->write.groups = c->groups;
    j->write.group_count = c->group_count;
    return failed;
}

/* Writes tetrahedra alone: pages show nothing of the model. */
static int write_tets(job *j, const elements *e, const pbw_tets *tets)
{
    pbw_index *regions = NULL;
    int failed = name_patches(j, e, tets);
    if (is_given(j, "--quality")) {
        describe_measures(j, tets);
    }
    show_tets(j, tets);
    if (!failed && j->write.groups != NULL) {        /* tetrahedra are in no group */
        regions = (pbw_index *)malloc((tets->tet_count + 1) * sizeof *regions);
        if (regions != NULL) {
            memset(regions, 0xff, tets->tet_count * sizeof *regions);            /* PBW_NONE */
        }
        failed = regions != NULL ? 0 : fail(j, "out of memory");
        j->write.regions = regions;
    }
    j->cloud.count = j->cloud.triangle_count = j->cloud.segment_count = 0;
    failed = failed ? failed : write_mesh(j);
    drop_groups(j);
    free(regions);
    memset(&j->mesh, 0, sizeof j->mesh);
    return failed;
}

/* ---- the commands ---- */

/* Returns the processor time that --seconds leaves; 0: there is no limit. */
static double seconds_left(const job *j)
{
    const double seconds = number_of(j, "--seconds", 0);
    return seconds > 0 ? fmax(seconds - (double)clock() / CLOCKS_PER_SEC, 1e-3) : 0;
}

/* Wraps what is loaded. */
static int wrap_elements(job *j, const elements *e, const pbw_wrap_options *how)
{
    pbw_wrap_report report;
    pbw_wrap_result wrap;
    pbw_tets tets;
    double distance[2];
    pbw_status status = pbw_wrap(&e->in, how, &j->build, &wrap, &report);
    int failed = status != PBW_OK ? refuse(j, status, &report) : 0;
    memset(&tets, 0, sizeof tets);
    if (!failed) {
        report_on(j, &report, wrap.facet_count, wrap.point_count, wrap.tet_count);
        failed = explain(j, pbw_wrap_distance(&e->in, wrap.points, wrap.point_count, wrap.facets, wrap.facet_count,
                                              &j->build, distance));
    }
    if (!failed) {
        report_line(j, "the wrap is up to %.6g from the model, the model up to %.6g from the wrap", distance[0],
                    distance[1]);
        tets.points = wrap.points;
        tets.point_count = wrap.point_count;
        tets.corners = wrap.corners;
        tets.tet_count = wrap.tet_count;
        tets.neighbors = wrap.neighbors;
        failed = write_tets(j, e, &tets);
    }
    pbw_wrap_free(&wrap);
    return failed;
}

/* Fills a wrap of what is loaded. */
static int fill_wrap(job *j, const elements *e, pbw_wrap_solid_options *how)
{
    pbw_wrap_solid_report report;
    pbw_tets made;
    pbw_status status;
    int failed;
    how->stage = &j->stage;
    status = pbw_wrap_solid(&e->in, how, &j->build, &made, &report);
    j->stage = NULL;
    failed = status != PBW_OK ? refuse(j, status, &report.wrap) : 0;
    if (!failed) {
        report_on_solid(j, &made, &report);
        failed = write_tets(j, e, &made);
    }
    pbw_tets_free(&made);
    return failed;
}

/* Loads the input and wraps it; solid: good tetrahedra, of --size. */
static int run_both(job *j, int solid)
{
    pbw_wrap_solid_options how;
    pbwio_cloud seeds;
    elements e;
    sizing alphas;
    char *end = NULL;
    const char *size = solid ? text_of(j, "--size") : NULL;
    int failed;
    memset(&seeds, 0, sizeof seeds);
    memset(&how, 0, sizeof how);
    memset(&e, 0, sizeof e);
    memset(&alphas, 0, sizeof alphas);
    how.size = size != NULL ? strtod(size, &end) : 0;
    if (size != NULL && (*end != 0 || !(how.size > 0))) {
        return complain("--size %s: with --wrap it is a number above 0", size);
    }
    j->read.dim = 3;
    failed = load_sizes(j, "--alpha", 0);
    failed = failed ? failed : complete_groups(j);
    failed = failed ? failed : load_seeds(j, &seeds, &how.wrap);
    failed = failed ? failed : find_elements(j, &e);
    failed = failed ? failed : set_alphas(j, &alphas, &how.wrap);
    how.wrap.offset *= solid ? 15 : 1;               /* half of the least alpha */
    how.wrap.offset = number_of(j, "--offset", how.wrap.offset);
    how.wrap.most = number_of(j, "--most", 0);
    how.wrap.fast = is_given(j, "--fast");
    how.wrap.closing = 1;
    how.stay = is_given(j, "--offset");
    how.target = number_of(j, "--target", 0);
    how.seconds = how.wrap.seconds = seconds_left(j);
    failed = failed ? failed : solid ? fill_wrap(j, &e, &how) : wrap_elements(j, &e, &how.wrap);
    pbwio_free(&seeds);
    free_sizes(&alphas);
    free(e.boundary);
    free(e.singles);
    return failed;
}

int wrap_solid(job *j)
{
    return run_both(j, 1);
}

static int run(job *j)
{
    return run_both(j, 0);
}

const command command_wrap = {
    .name = "wrap",
    .summary = "close any model: a surface around it",
    .usage =
    "usage: pbw wrap [options] model [-o output]...\n"
    "\n"
    "Wraps faces, segments and points, with holes, crossings and gaps, in a closed surface that touches nothing of\n"
    "them and encloses all of it.  A ball of radius alpha does not get in: a smaller alpha follows the model more\n"
    "closely, and goes into smaller holes.  The points of the surface are at the offset from the model.  Facets\n"
    "have the group of the nearest face.  Formats of meshes get the tetrahedra inside, of any shape; pbw solid\n"
    "--wrap makes good ones.\n"
    "\n"
    "input:   .obj .ply .stl .off .msh .mesh .inp .vtu .vtk .csv .xyz and others: faces, segments, points, and of\n"
    "         tetrahedra their boundary\n"
    "output:  .obj .ply .stl .off (surface), .vtu .msh .msh2 .mesh .inp .su2 .node .ele .neigh .face (tetrahedra,\n"
    "         surface), .svg (picture), .html (page to look around in); any number of them\n"
    "\n",
    .writes = "vtu msh msh2 mesh inp su2 node ele neigh face obj ply stl off svg html",
    .options = { wrapping_options, wrap_options, input_options, look_options, build_options, output_options,
                 text_options, common_options, NULL },
    .run = run,
};
