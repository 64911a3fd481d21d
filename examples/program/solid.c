/* solid.c: pbw solid.
   In: a surface, perhaps with groups of faces.  Out: tetrahedra, their boundary with those groups, and a report. */
#include "program.h"

static const char *const sharp_names[] = { "auto", "all", "some", "none", NULL };    /* as PBW_SOLID_SHARP_... */

static const option solid_options[] = {
    OPTION_SIZE("at most"),
    { "--least-size", "H", "edges are not shorter where walls are thin; default: 1/6 of the size, 1/3 without\n"
      "sharp edges", POSITIVE, 0, 0,
      NULL },
    { "--region-sizes", "R=H,...", "in region number R, and on its boundary, edges are H long at most", PLAIN,
      0, 0, NULL },
    { "--curvature", "C", "edges of at most C / curvature, the root of its squares' sum; default: any", POSITIVE,
      0, 0, NULL },
    { "--around", "N", "edges around a circle, at least: as --curvature 2 pi / N", POSITIVE, 0, 0, NULL },
    OPTION_GRADATION("sizes grow by at most G for each unit of length; default 0.35"),
    OPTION_NESTED(",\nand shells that cross are one body"),
    { "--sharp", "WHICH", "sharp edges to keep: all, some (those that are sharp at the scale of the size), none,\n"
      "or auto, the default: by how many of them are", CHOICE, 0, 0, sharp_names },
    { "--close", NULL, "closes large holes, and fills thin sheets, which are refused else", SWITCH, 0, 0, NULL },
    { "--wrap", NULL, "fills a wrap of the model instead: any faces, segments and points, with holes,\n"
      "crossings and gaps; sharp edges are rounded off by about alpha, and sheets become\n"
      "plates, 1/4 of the size thick", SWITCH, 0, 0, NULL },
    { "--keep-faults", NULL, "writes a boundary that is no manifold, too", SWITCH, 0, 0, NULL },
    OPTION_MOST("tetrahedra"),
    { "--patches", NULL, "list patches: the groups of the model, which are kept anyway; of a model without\n"
      "groups those between sharp edges, which are then written", SWITCH, 0, 0, NULL },
    { "--split-patches", NULL, "the same, but sharp edges cut groups, too: those of several parts become NAME_1,\n"
      "NAME_2 and so on, in the order of the model's faces", SWITCH, 0, 0, NULL },
    OPTION_FEATURE_ANGLE,
    { "--distance", "D", "facets farther than D sizes from the surface get points; default 0.1", POSITIVE, 0, 0,
      NULL },
    OPTION_ROUNDS("of adding points, at most, default 16, or 24 where tips need them"),
    OPTION_TARGET("; default 30"),
    OPTION_SECONDS,
    OPTION_QUALITY,
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

/* ---- the report ---- */

static void list_holes(const job *j, const pbw_solid_report *r)
{
    size_t i;
    report_line(j, "%zu hole%s of the surface%s:", COUNT(r->holes),
                r->holes > PBW_SOLID_PLACES ? ", the largest of them" : "");
    for (i = 0; i < PBW_SOLID_PLACES && i < r->holes; i++) {
        const pbw_solid_hole *h = r->hole + i;
        report_line(j, "  %zu edge%s, length %.6g, around (%.6g, %.6g, %.6g), %s", COUNT(h->edges), h->length,
                    h->place[0], h->place[1], h->place[2],
                    h->closed ? "closed by triangles" : "no loop: closed by the winding number");
    }
}

static void warn_of(const job *j, const pbw_solid_report *r)
{
    size_t i;
    if (r->open_edges > 0) {
        warn(j, "the surface has %zu open edge%s and %zu of more than two triangles", COUNT(r->open_edges),
             r->crowded_edges);
    } else if (r->crowded_edges + r->doubles > 0) {
        report_line(j, "walls between regions: %zu edge%s of more than two triangles, %zu triangle%s given again",
                    COUNT(r->crowded_edges), COUNT(r->doubles));
    }
    if (r->holes > 0) {
        list_holes(j, r);
    }
    if (r->crossings > 0) {
        warn(j, "the surface meets itself: %zu pair%s of faces, the first at (%.6g, %.6g, %.6g); pbw check lists "
             "them%s", COUNT(r->crossings), r->crossing_place[0], r->crossing_place[1], r->crossing_place[2],
             r->united ? "; the solid is the union" : "");
    }
    if (r->closing_crossings > 0) {
        warn(j, "the triangles that close holes meet the surface or each other: %zu pair%s of faces; --wrap closes "
             "holes without", COUNT(r->closing_crossings));
    }
    if (r->acute_edges > 0) {
        warn(j, "%zu sharp edge%s of the surface below 60 degrees, the least %.2f: tetrahedra there are no better",
             COUNT(r->acute_edges), r->least_angle);
    }
    if (!r->settled) {
        warn(j, "not settled after %zu round%s: walls, gaps or details thinner than the size; a smaller --size may "
             "do", COUNT(r->rounds));
    }
    if (r->missing_edges > 0) {
        warn(j, "%zu piece%s of sharp edges %s missing", COUNT(r->missing_edges),
             r->missing_edges == 1 ? "is" : "are");
    }
    if (r->bad_edges + r->bad_points > 0) {
        warn(j, "the boundary is no manifold at %zu edge%s and %zu point%s; the first places:", COUNT(r->bad_edges),
             COUNT(r->bad_points));
        for (i = 0; i < PBW_SOLID_PLACES && i < r->bad_edges + r->bad_points; i++) {
            warn(j, "  %.9g %.9g %.9g", r->places[i][0], r->places[i][1], r->places[i][2]);
        }
    }
    if (r->distance > 0.15) {
        warn(j, "the boundary and the surface are up to %.3f sizes apart; a smaller --size brings them nearer",
             r->distance);
    }
    if (r->crossings == 0 && r->open_edges == 0 && r->euler != r->input_euler) {
        warn(j, "the Euler number of the boundary is %ld, that of the surface %ld", r->euler, r->input_euler);
    }
}

static void report_on(const job *j, const pbw_tets *mesh, const pbw_solid_report *r)
{
    const double seconds = r->seconds[0] + r->seconds[1] + r->seconds[2];
    report_step(j, "sample", r->seconds[0], "%zu corner%s, %zu sharp edge%s", COUNT(r->corners),
                COUNT(r->sharp_edges));
    report_step(j, "rounds", r->seconds[1], "%d, %s", r->rounds, r->settled ? "settled" : "not settled");
    report_step(j, "improve", r->seconds[2], "%d pass%s", r->improve.passes, r->improve.passes == 1 ? "" : "es");
    report_step(j, "measure", r->seconds[3], "%s", "");
    report_line(j, "%zu %s in %zu region%s, %zu point%s, %zu facet%s on boundaries; %.0f tetrahedra a second",
                mesh->tet_count, simplices(3, mesh->tet_count), COUNT(r->regions), COUNT(mesh->point_count),
                COUNT(r->facets), seconds > 0 ? (double)mesh->tet_count / seconds : 0);
    describe_quality(j, "before: ", &r->improve.before);
    describe_quality(j, "after:  ", &r->improve.after);
    describe_histogram(j, &r->improve.after);
    if (is_given(j, "--quality")) {
        describe_measures(j, mesh);
    }
    report_line(j, "Euler number %ld, of the %s %ld; edges that are no manifold %zu, points %zu", r->euler,
                r->united ? "united surface, contacts counted once," : "surface", r->input_euler, r->bad_edges,
                r->bad_points);
    report_line(j, "Hausdorff distance %.3f sizes of %.6g; volume %.9g, of the surface %.9g", r->distance, r->size,
                r->improve.after.volume, r->input_volume);
    warn_of(j, r);
}

/* ---- groups of the input's faces ---- */

typedef struct naming {                              /* of the outputs */
    pbwio_group *groups;                             /* the input's, parts of them, a region each, "hole" if there is
                                                        one; NULL if the input has none */
    size_t count, all;                               /* of the input's; of them all */
    long long most;                                  /* tags of patches are at most this */
    pbw_index *patches;                              /* of each facet: its place in `groups`; without, a number */
} naming;

/* Returns "name_number", NULL if there is no memory. */
static char *numbered(const char *name, size_t number)
{
    char *text = (char *)malloc(strlen(name) + 24);
    if (text != NULL) {
        sprintf(text, "%s_%zu", name, number);
    }
    return text;
}

/* Adds the group "name_number", or one without a name.  Returns 0 if there is no memory. */
static int add_group(naming *n, int dim, long long tag, const char *name, size_t number)
{
    pbwio_group *g = n->groups + n->all++;
    g->dim = dim;
    g->tag = tag;
    g->name = name == NULL ? NULL : numbered(name, number);
    return name == NULL || g->name != NULL;
}

/* Makes groups of the parts that sharp edges cut a group's patch into, in the order of the model's faces. */
static int split_groups(naming *n, const pbw_solid_boundary *b, size_t parts)
{
    size_t *group_of = (size_t *)calloc(2 * parts + 1, sizeof *group_of), *place = group_of + parts, i;
    size_t *number = (size_t *)calloc(n->count + 1, sizeof *number);           /* how many parts a group has */
    int good = group_of != NULL && number != NULL;
    for (i = 0; good && i < b->facet_count; i++) {
        if (n->patches[i] < n->count && group_of[b->parts[i]] == 0) {
            group_of[b->parts[i]] = (size_t)n->patches[i] + 1;
        }
    }
    for (i = 0; good && i < parts; i++) {
        const size_t group = group_of[i] - 1;
        if (group_of[i] > 0 && number[group]++ > 0) {
            place[i] = n->all;
            good = add_group(n, 2, ++n->most, n->groups[group].name, number[group]);
        }
    }
    for (i = 0; good && i < n->count; i++) {         /* the first part has the group's place and tag */
        if (number[i] > 1 && n->groups[i].name != NULL) {
            char *name = numbered(n->groups[i].name, 1);
            good = name != NULL;
            free(n->groups[i].name);
            n->groups[i].name = name;
        }
    }
    for (i = 0; good && i < b->facet_count; i++) {
        if (n->patches[i] < n->count && place[b->parts[i]] > 0) {
            n->patches[i] = (pbw_index)place[b->parts[i]];
        }
    }
    free(group_of);
    free(number);
    return good;
}

/* Takes the groups out of the cloud, adds parts of them, and one for each region. */
static int name_groups(job *j, const pbw_tets *mesh, const pbw_solid_boundary *b, naming *n)
{
    pbwio_cloud *c = &j->cloud;
    size_t i, regions = 0, parts = 0, first;
    int good = 1, hole = 0;
    n->patches = (pbw_index *)malloc((b->facet_count + 1) * sizeof *n->patches);
    for (i = 0; i < mesh->tet_count; i++) {
        regions = mesh->regions[i] >= regions ? (size_t)mesh->regions[i] + 1 : regions;
    }
    for (i = 0; n->patches != NULL && i < b->facet_count; i++) {
        n->patches[i] = b->patches[i];
        parts = b->parts[i] != PBW_NONE && b->parts[i] >= parts ? (size_t)b->parts[i] + 1 : parts;
        hole |= b->patches[i] == PBW_NONE;
    }
    if (c->triangle_groups == NULL) {
        return n->patches != NULL ? 0 : fail(j, "out of memory");
    }
    n->groups = (pbwio_group *)calloc(c->group_count + parts + regions + 1, sizeof *n->groups);
    if (n->groups == NULL || n->patches == NULL) {
        return fail(j, "out of memory");
    }
    n->count = n->all = c->group_count;
    memcpy(n->groups, c->groups, n->count * sizeof *n->groups);
    for (i = 0; i < n->count; i++) {
        n->most = n->groups[i].dim == 2 && n->groups[i].tag > n->most ? n->groups[i].tag : n->most;
        c->groups[i].name = NULL;                    /* it is ours now */
    }
    good = !is_given(j, "--split-patches") || split_groups(n, b, parts);
    for (i = 0, first = n->all; good && i < regions; i++) {
        good = add_group(n, 3, (long long)i + 1, "region", i);
    }
    for (i = 0; good && i < b->facet_count; i++) {   /* of faces in no group: PBW_NONE */
        n->patches[i] = b->patches[i] == PBW_NONE ? (pbw_index)(first + regions)
                      : b->patches[i] == n->count ? PBW_NONE : n->patches[i];
    }
    if (good && hole) {
        pbwio_group *g = n->groups + n->all++;
        g->dim = 2;
        g->tag = n->most + 1;
        g->name = (char *)malloc(sizeof "hole");
        good = g->name != NULL;
        if (good) {
            strcpy(g->name, "hole");
        }
    }
    return good ? 0 : fail(j, "out of memory");
}

static void free_naming(naming *n)
{
    size_t i;
    for (i = 0; i < n->all; i++) {
        free(n->groups[i].name);
    }
    free(n->groups);
    free(n->patches);
}

/* A line for each patch that has facets: its tag, name, their number, area and centre. */
static void list_patches(const job *j, const pbw_tets *mesh, const pbw_solid_boundary *b, const naming *n)
{
    size_t i, k, count = n->all;
    double *sum;                                     /* area, centre, facets */
    for (i = 0; i < b->facet_count && n->groups == NULL; i++) {
        count = n->patches[i] != PBW_NONE && n->patches[i] >= count ? (size_t)n->patches[i] + 1 : count;
    }
    sum = (double *)calloc(count + 1, 5 * sizeof *sum);
    for (i = 0; sum != NULL && i < b->facet_count; i++) {
        const pbw_index *f = b->facets + 3 * i;
        const double *p = mesh->points + 3 * (size_t)f[0], *q = mesh->points + 3 * (size_t)f[1];
        const double *r = mesh->points + 3 * (size_t)f[2];
        double area = 0, *s = sum + 5 * (n->patches[i] < count ? n->patches[i] : count);
        for (k = 0; k < 3; k++) {
            const size_t u = (k + 1) % 3, v = (k + 2) % 3;
            area += pow((q[u] - p[u]) * (r[v] - p[v]) - (q[v] - p[v]) * (r[u] - p[u]), 2);
        }
        area = sqrt(area) / 2;
        s[0] += area;
        s[4] += 1;
        for (k = 0; k < 3; k++) {
            s[1 + k] += area * (p[k] + q[k] + r[k]) / 3;
        }
    }
    for (i = 0; sum != NULL && i <= count; i++) {
        const double *s = sum + 5 * i;
        char number[32] = "others";
        const char *name = i < n->all && n->groups[i].name != NULL ? n->groups[i].name : i < n->all ? "" : number;
        if (n->groups == NULL && i < count) {
            sprintf(number, "patch_%zu", i);         /* as in files */
        } else if (n->groups == NULL) {
            strcpy(number, "hole");
        }
        if (s[4] > 0) {
            report_line(j, "patch %lld %s: %.0f facet%s, area %.6g, centre (%.6g, %.6g, %.6g)",
                        i == count ? 0 : n->groups == NULL ? (long long)i + 1 : n->groups[i].tag, name, s[4],
                        plural((size_t)s[4]), s[0], s[1] / s[0], s[2] / s[0], s[3] / s[0]);
        }
    }
    free(sum);
}

/* ---- the output ---- */

/* Writes the tetrahedra with regions, and patches of facets, as both of their sides have them. */
static int write_solid(job *j, const pbw_tets *mesh, const pbw_solid_boundary *boundary, const naming *n)
{
    pbw_index *patches = (pbw_index *)malloc((4 * mesh->tet_count + 1) * sizeof *patches);
    pbw_index *regions = (pbw_index *)malloc((mesh->tet_count + 1) * sizeof *regions);
    size_t i, k, first = 0;
    int failed = patches == NULL || regions == NULL ? fail(j, "out of memory") : 0;
    while (first < n->all && (first < n->count || n->groups[first].dim == 2)) {
        first++;                                     /* to the first region */
    }
    for (i = 0; !failed && i < 4 * mesh->tet_count; i++) {
        patches[i] = PBW_NONE;
        regions[i / 4] = (pbw_index)first + mesh->regions[i / 4];
    }
    for (i = 0; !failed && i < boundary->facet_count; i++) {
        const pbw_index corner = boundary->corners[i], next = mesh->neighbors[corner];
        patches[corner] = n->patches[i];
        for (k = 0; k < 4 && next != PBW_NONE; k++) {
            if (mesh->neighbors[4 * (size_t)next + k] == corner / 4) {
                patches[4 * (size_t)next + k] = patches[corner];
            }
        }
    }
    j->write.regions = regions;
    j->write.patches = n->groups != NULL || is_given(j, "--patches") || is_given(j, "--split-patches") ? patches
                     : NULL;
    j->write.edges = boundary->edges;
    j->write.edge_count = boundary->edge_count;
    j->write.groups = n->groups;
    j->write.group_count = n->all;
    failed = failed ? failed : write_mesh(j);
    drop_groups(j);
    free(patches);
    free(regions);
    return failed;
}

/* ---- the command ---- */

/* Before work: how many tetrahedra there will be. */
static void announce(void *user, const pbw_solid_report *r)
{
    const job *j = (const job *)user;
    const double scale = pow(10, floor(log10(fmax(r->estimate, 1))) - 1);
    report_line(j, "about %.0f tetrahedra of size %.6g", scale * floor(r->estimate / scale + 0.5), r->size);
    if (r->sharp_share >= 0) {
        report_line(j, "sharp edges: %s are kept, as %.0f %% of them are sharp at the scale of the size",
                    sharp_names[r->sharp], 100 * r->sharp_share);
    }
}

/* Takes --region-sizes; *sizes: for the caller to free. */
static int take_region_sizes(const job *j, pbw_solid_options *how, double **sizes)
{
    const char *text = text_of(j, "--region-sizes"), *at = text;
    *sizes = NULL;
    while (at != NULL) {
        char *end;
        const double region = strtod(at, &end), size = *end == '=' ? strtod(end + 1, &end) : 0;
        double *more;
        if (!(*at >= '0' && *at <= '9' && region < 1e6 && floor(region) >= region && size > 0 && size <= DBL_MAX)
            || (*end != 0 && *end != ',')) {
            return complain("--region-sizes %s: R=H is needed at \"%s\", a number and a size above 0", text, at);
        }
        if ((size_t)region >= how->region_size_count) {
            more = (double *)realloc(*sizes, ((size_t)region + 1) * sizeof *more);
            if (more == NULL) {
                return fail(j, "out of memory");
            }
            *sizes = more;
            memset(more + how->region_size_count, 0, ((size_t)region + 1 - how->region_size_count) * sizeof *more);
            how->region_size_count = (size_t)region + 1;
        }
        (*sizes)[(size_t)region] = size;
        at = *end == ',' ? end + 1 : NULL;
    }
    how->region_sizes = *sizes;
    return 0;
}

static pbw_solid_options options_of(job *j)
{
    pbw_solid_options how;
    memset(&how, 0, sizeof how);
    how.least_size = number_of(j, "--least-size", 0);
    how.curvature = number_of(j, "--curvature", 0);
    if (is_given(j, "--around")) {
        const double around = 6.283185307179586 / number_of(j, "--around", 0);
        how.curvature = how.curvature > 0 ? fmin(how.curvature, around) : around;
    }
    how.gradation = number_of(j, "--gradation", 0);
    how.nested = is_given(j, "--nested");
    how.close = is_given(j, "--close");
    how.sharp = is_given(j, "--sharp") ? choice_of(j, "--sharp") : PBW_SOLID_SHARP_AUTO;
    how.most = number_of(j, "--most", 0);
    how.plan = announce;
    how.plan_user = j;
    how.stage = &j->stage;
    how.feature_angle = number_of(j, "--feature-angle", 0);
    how.distance = number_of(j, "--distance", 0);
    how.rounds = (int)number_of(j, "--rounds", 0);
    how.improve.target = number_of(j, "--target", 0);
    how.improve.seconds = number_of(j, "--seconds", 0);
    return how;
}

/* Says why there is no solid, and what to do. */
static int refuse(const job *j, pbw_status status, const pbw_solid_report *r)
{
    const pbw_solid_hole *h = r->hole;
    switch (r->refusal) {
    case PBW_SOLID_OPEN:
        return fail(j, "%s: it is open: %zu hole%s, %.0f %% as large as its faces; the largest has %zu edge%s, around"
                    " (%.6g, %.6g, %.6g); --close closes them", j->input, COUNT(r->holes), 100 * r->hole_share,
                    COUNT(h->edges), h->place[0], h->place[1], h->place[2]);
    case PBW_SOLID_THIN:
        return fail(j, "%s: it is about %.3g thick, %.2g of the size %.6g; --size %.2g suits it%s", j->input,
                    r->thickness * r->size, r->thickness, r->size, 3 * r->thickness * r->size,
                    r->thickness > 0.02 ? "" : ", --close fills it anyway");
    case PBW_SOLID_LARGE:
        return fail(j, "%s: about %.2g tetrahedra, more than --most allows; a larger --size needs fewer", j->input,
                    r->estimate);
    case PBW_SOLID_LATE:
        return fail(j, "%s: --seconds were over before there was a mesh; a larger --size needs less time",
                    j->input);
    default:
        return status == PBW_DEGENERATE ? fail(j, "%s: nothing is inside of it: it is an open sheet, or thinner than "
                                               "the size; pbw check says where it is open", j->input)
             : explain_file(j, status, "");
    }
}

static int run(job *j)
{
    pbw_solid_boundary boundary;
    pbw_solid_input input;
    pbw_solid_options how;
    pbw_solid_report report;
    pbw_tets mesh;
    pbw_status status;
    naming names;
    sizing sizes;
    double *region_sizes = NULL;
    size_t i;
    int failed;
    if (is_given(j, "--wrap")) {
        return wrap_solid(j);
    }
    failed = load_sizes(j, "--size", 0);
    failed = failed ? failed : complete_faces(j);
    if (failed) {
        return failed;
    }
    memset(&input, 0, sizeof input);
    input.points = j->cloud.points;
    input.point_count = j->cloud.count;
    input.triangles = j->cloud.triangles;
    input.triangle_count = j->cloud.triangle_count;
    for (i = 0; j->cloud.triangle_groups != NULL && i < j->cloud.triangle_count; i++) {
        pbw_index *group = j->cloud.triangle_groups + i;
        *group = *group == PBW_NONE ? (pbw_index)j->cloud.group_count : *group;
    }
    input.patches = j->cloud.triangle_groups;
    how = options_of(j);
    failed = set_sizes(j, &sizes, &how);
    failed = failed ? failed : take_region_sizes(j, &how, &region_sizes);
    status = failed ? PBW_OK : pbw_solid(&input, &how, &j->build, &mesh, &boundary, &report);
    free_sizes(&sizes);
    free(region_sizes);
    if (failed) {
        return failed;
    }
    if (status != PBW_OK) {
        return refuse(j, status, &report);
    }
    report_on(j, &mesh, &report);
    memset(&names, 0, sizeof names);
    failed = name_groups(j, &mesh, &boundary, &names);
    pbwio_free(&j->cloud);                           /* pages show the solid alone */
    show_tets(j, &mesh);
    if (!failed && (is_given(j, "--patches") || is_given(j, "--split-patches"))) {
        list_patches(j, &mesh, &boundary, &names);
    }
    if (!failed && report.bad_edges + report.bad_points > 0 && !is_given(j, "--keep-faults")) {
        failed = fail(j, "the boundary is no manifold, so nothing is written; a smaller --size mends it where gaps "
                      "or walls are thin, or a smaller --least-size; --keep-faults writes it");
    }
    failed = failed ? failed : write_solid(j, &mesh, &boundary, &names);
    free_naming(&names);
    pbw_solid_boundary_free(&boundary);
    memset(&j->mesh, 0, sizeof j->mesh);
    pbw_tets_free(&mesh);
    return failed;
}

const command command_solid = {
    .name = "solid",
    .summary = "fill a closed surface with tetrahedra",
    .usage =
    "usage: pbw solid [options] model [-o output]...\n"
    "\n"
    "Fills a surface with good tetrahedra; holes are closed, and shells that cross are made one, with sharp\n"
    "edges where they cross.  Sharp edges are kept; elsewhere the boundary is within a fraction of the size, which\n"
    "is 1/40 of the diagonal if not given.  Regions are numbers of shells: data of cells in .vtu, groups in .msh\n"
    "and .inp, tags or references in .msh2, .mesh and .ele.  The report ends with warnings where the boundary is\n"
    "not that of the model.\n"
    "\n"
    "input:   .obj .ply .stl .off .poly .smesh with faces that enclose something\n"
    "output:  .vtu .msh .msh2 .mesh .inp .su2 .node .ele .neigh .face (tetrahedra, boundary), .obj .ply .stl .off\n"
    "         (boundary), .svg (picture), .html (page to look around in); any number of them\n"
    "\n",
    .writes = "vtu msh msh2 mesh inp su2 node ele neigh face obj ply stl off svg html",
    .options = { solid_options, wrapping_options, look_options, build_options, output_options, text_options,
                 common_options, NULL },
    .run = run,
};
