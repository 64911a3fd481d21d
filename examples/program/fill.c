/* fill.c: pbw fill.
   In: a surface, perhaps with groups of faces, holes and regions.  Out: tetrahedra with its own triangles as facets,
   regions, groups. */
#include "program.h"

static const option fill_options[] = {
    OPTION_CONFORMING("points may stay on edges; flat parts of the surface are unions of facets"),
    { "--split-flat", NULL, "with --conforming: edges between coplanar faces are kept, too", SWITCH, 0, 0, NULL },
    OPTION_NESTED(""),
    { "--outside", NULL, "keep the outside, too, up to a box five times as wide as the surface's", SWITCH, 0, 0,
      NULL },
    { "--faces", NULL, "groups of facets are the model's faces, numbered from 1 on, not its groups", SWITCH, 0, 0,
      NULL },
    OPTION_TARGET(", as far as the faces\nallow; default: no better angles"),
    OPTION_SIZE("inside"),
    OPTION_GRADATION("without --size: edges inside grow by this a unit of distance from the faces; default 0.3"),
    { "--ratio", "R", "radius of a tetrahedron's sphere by its shortest edge, at most; default 2 with a\n"
      "size, else any", POSITIVE, 0, 0, NULL },
    { "--volume", "V", "of a tetrahedron, at most", POSITIVE, 0, 0, NULL },
    { "--volumes", NULL, "the same of each region of a .poly or .smesh file, as the file says", SWITCH, 0, 0, NULL },
    OPTION_SECONDS,
    OPTION_MOST("points on edges"),
    OPTION_QUALITY,
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

/* Whether the caller asks for points inside. */
static int adds_points(const job *j)
{
    return is_given(j, "--size") || is_given(j, "--ratio") || is_given(j, "--volume") || is_given(j, "--volumes");
}

/* ---- the report ---- */

static void report_on(const job *j, const pbw_filled *f, const pbw_fill_report *r)
{
    static const char *const stages[] = { "vertices", "triangulate", "edges", "crossings", "segments", "facets",
                                          "regions", "exact", "inside", "improve" };
    pbw_quality quality;
    size_t i;
    for (i = 0; i < sizeof stages / sizeof *stages; i++) {
        if ((i == 8 && !adds_points(j)) || (i == 9 && !is_given(j, "--target"))) {
            continue;
        }
        if (i == 8) {
            report_step(j, stages[i], r->seconds[i], "%zu point%s; %zu %s too large and %zu too slim, at faces",
                        COUNT(r->inside_points), r->too_large, simplices(3, r->too_large), r->too_slim);
        } else if (i == 4) {
            report_step(j, stages[i], r->seconds[i], "%zu, of them %zu missing: %zu point%s added", r->segments,
                        r->missing_segments, COUNT(r->segment_points));
        } else if (i == 5) {
            report_step(j, stages[i], r->seconds[i], "%zu, of them %zu missing", r->facets, r->missing_facets);
        } else {
            report_step(j, stages[i], r->seconds[i], "%s", "");
        }
    }
    report_line(j, "%zu %s in %zu region%s, %zu point%s, %zu of them new, %zu facet%s on the surface",
                f->tets.tet_count, simplices(3, f->tets.tet_count), COUNT(r->regions), COUNT(f->tets.point_count),
                r->inner_points, COUNT(f->facet_count));
    if (is_given(j, "--target")) {
        describe_quality(j, "before: ", &r->improve.before);
    }
    if (pbw_tets_quality(&f->tets, &j->build, &quality)) {
        describe_quality(j, is_given(j, "--target") ? "after:  " : "angles: ", &quality);
    }
    if (is_given(j, "--target") && r->inner.least > 0) {
        describe_quality(j, "away from the surface: ", &r->inner);
    }
    if (is_given(j, "--quality")) {
        describe_measures(j, &f->tets);
    }
    if (r->doubles + r->collapsed > 0) {
        report_line(j, "left out: %zu face%s with the corners of another, %zu with two corners at one place",
                    COUNT(r->doubles), r->collapsed);
    }
    if (r->refusal == PBW_FILL_POINTS_LEFT) {
        warn(j, "%zu point%s left on edges, the first on face %lu", COUNT(r->fault_count),
             (unsigned long)r->faults[0][0]);
    }
    if (r->flat_tets > 0) {
        warn(j, "%zu %s no volume above 0: coordinates are too near to each other for their size", r->flat_tets,
             r->flat_tets == 1 ? "tetrahedron has" : "tetrahedra have");
    }
}

static void describe_fault(const job *j, int refusal, const pbw_index fault[2])
{
    const pbw_index a = fault[0], b = fault[1];
    int k;
    for (k = 0; k < 2 && refusal == PBW_FILL_SEED && fault[k] != PBW_NONE; k++) {
        const double *x = j->cloud.seeds[fault[k]].place;
        report_line(j, "  seed %lu, at %.9g %.9g %.9g", (unsigned long)fault[k], x[0], x[1], x[2]);
    }
    if (refusal != PBW_FILL_SEED && a != PBW_NONE && b != PBW_NONE) {
        report_line(j, "  %s %lu and %lu", refusal == PBW_FILL_CROSSING ? "faces" : "numbers", (unsigned long)a,
                    (unsigned long)b);
    } else if (refusal != PBW_FILL_SEED && a != PBW_NONE) {
        report_line(j, "  face %lu", (unsigned long)a);
    }
}

/* Says why the surface is refused, and where. */
static int refuse(const job *j, pbw_status status, const pbw_fill_report *r)
{
    size_t i;
    if (status != PBW_DEGENERATE) {
        return explain_file(j, status, "");
    }
    fail(j, "%s: %s%s", j->input, pbw_fill_refusal(r->refusal), r->refusal == PBW_FILL_OPEN
         ? "; --outside keeps what is on both sides, pbw solid closes it by --close or --wrap"
         : r->refusal == PBW_FILL_CROSSING ? "; pbw check lists all places"
         : r->refusal == PBW_FILL_FLAT ? "; pbw check lists all of them, pbw solid takes such a surface" : "");
    for (i = 0; i < r->fault_count && i < PBW_FILL_PLACES; i++) {
        describe_fault(j, r->refusal, r->faults[i]);
    }
    if (r->fault_count > PBW_FILL_PLACES) {
        report_line(j, "  and %zu more", r->fault_count - PBW_FILL_PLACES);
    }
    return FAILURE;
}

/* ---- holes and regions of the file ---- */

typedef struct seeding {                             /* what pbw_fill gets; start from {0} */
    double *places;
    pbw_index *regions;
    pbw_index *groups;                               /* of each region: the file's */
    double *volumes;                                 /* the largest of a tetrahedron; 0: any */
    size_t count, region_count;
} seeding;

/* Gives each group of regions a number.  Returns 0 without memory. */
static int take_seeds(const pbwio_cloud *c, seeding *s)
{
    pbw_index *region = (pbw_index *)malloc((c->group_count + 1) * sizeof *region);
    size_t i;
    s->places = (double *)malloc((3 * c->seed_count + 1) * sizeof *s->places);
    s->regions = (pbw_index *)malloc((c->seed_count + 1) * sizeof *s->regions);
    s->groups = (pbw_index *)malloc((c->group_count + 1) * sizeof *s->groups);
    s->volumes = (double *)calloc(c->group_count + 1, sizeof *s->volumes);
    if (region == NULL || s->places == NULL || s->regions == NULL || s->groups == NULL || s->volumes == NULL) {
        free(region);
        return 0;
    }
    for (i = 0; i < c->group_count; i++) {
        region[i] = PBW_NONE;
    }
    for (; s->count < c->seed_count; s->count++) {
        const pbwio_seed *seed = c->seeds + s->count;
        memcpy(s->places + 3 * s->count, seed->place, 3 * sizeof(double));
        if (seed->group != PBW_NONE && region[seed->group] == PBW_NONE) {
            region[seed->group] = (pbw_index)s->region_count;
            s->groups[s->region_count++] = seed->group;
        }
        s->regions[s->count] = seed->group == PBW_NONE ? PBW_NONE : region[seed->group];
        if (seed->group != PBW_NONE && seed->bound > 0) {
            s->volumes[region[seed->group]] = seed->bound;
        }
    }
    free(region);
    return 1;
}

static void free_seeds(seeding *s)
{
    free(s->places);
    free(s->regions);
    free(s->groups);
    free(s->volumes);
}

/* A line for each region with a seed: its tetrahedra and volume. */
static void report_regions(const job *j, const pbw_filled *f, const seeding *s)
{
    size_t r, i;
    for (r = 0; r < s->region_count && r < MOST_SHOWN; r++) {
        double volume = 0;
        size_t count = 0;
        for (i = 0; i < f->tets.tet_count; i++) {
            const pbw_index *c = f->tets.corners + 4 * i;
            const double *p = f->tets.points;
            count += f->tets.regions[i] == r;
            volume += f->tets.regions[i] == r ? pbw_tet_measure(PBW_MEASURE_VOLUME, p + 3 * (size_t)c[0],
                                                                p + 3 * (size_t)c[1], p + 3 * (size_t)c[2],
                                                                p + 3 * (size_t)c[3]) : 0;
        }
        report_line(j, "region %lld: %zu %s, volume %.10g", j->cloud.groups[s->groups[r]].tag, count,
                    simplices(3, count), volume);
    }
}

/* ---- the output ---- */

typedef struct naming { pbwio_group *groups; size_t count, all; pbw_index *patches, *regions; } naming;

/* Gives facets the groups of the model's faces, and regions those of seeds or groups behind these.  Returns 0 without
   memory. */
static int name_groups(job *j, const pbw_filled *f, const seeding *seeds, naming *n)
{
    pbwio_cloud *c = &j->cloud;
    const size_t faces = 4 * f->tets.tet_count;
    const int named = c->triangle_groups != NULL && !is_given(j, "--faces");
    long long tag = 0;
    size_t i, regions = 0;
    for (i = 0; i < f->tets.tet_count; i++) {
        regions = f->tets.regions[i] >= regions ? (size_t)f->tets.regions[i] + 1 : regions;
    }
    regions = regions > seeds->region_count ? regions - seeds->region_count : 0;         /* those without a seed */
    n->count = named ? c->group_count : 0;
    n->patches = (pbw_index *)malloc((faces + 1) * sizeof *n->patches);
    n->regions = (pbw_index *)malloc((f->tets.tet_count + 1) * sizeof *n->regions);
    n->groups = (pbwio_group *)calloc(n->count + regions + 1, sizeof *n->groups);
    if (n->patches == NULL || n->regions == NULL || n->groups == NULL) {
        return 0;
    }
    for (i = 0; i < faces; i++) {
        const pbw_index face = f->tets.patches[i];
        n->patches[i] = face == PBW_NONE || !named ? face : c->triangle_groups[face];
    }
    for (i = 0; i < f->tets.tet_count; i++) {
        const pbw_index r = f->tets.regions[i];
        n->regions[i] = !named ? r : r < seeds->region_count ? seeds->groups[r]
                      : (pbw_index)(n->count - seeds->region_count) + r;
    }
    for (i = 0; i < n->count; i++) {
        tag = c->groups[i].dim == 3 && c->groups[i].tag > tag ? c->groups[i].tag : tag;
        n->groups[n->all++] = c->groups[i];
        c->groups[i].name = NULL;                    /* it is ours now */
    }
    for (i = 0; named && i < regions; i++) {
        pbwio_group *g = n->groups + n->all++;
        g->dim = 3;
        g->tag = tag + (long long)i + 1;
        g->name = (char *)malloc(32);
        if (g->name == NULL) {
            return 0;
        }
        sprintf(g->name, "region_%zu", i);
    }
    return 1;
}

static int write_filled(job *j, const pbw_filled *f, naming *n)
{
    int failed;
    j->write.regions = n->regions;
    j->write.patches = n->all > 0 || is_given(j, "--faces") ? n->patches : NULL;
    j->write.groups = n->all > 0 ? n->groups : NULL;
    j->write.group_count = n->all;
    pbwio_free(&j->cloud);                           /* pages show the tetrahedra alone */
    show_tets(j, &f->tets);
    failed = write_mesh(j);
    drop_groups(j);
    return failed;
}

/* ---- the command ---- */

/* What --size, --ratio and volumes ask for.  Returns 0 or the exit status. */
static int set_inside(job *j, const seeding *seeds, sizing *sizes, pbw_fill_options *how)
{
    pbw_solid_options of_size;
    int failed;
    memset(&of_size, 0, sizeof of_size);
    failed = set_sizes(j, sizes, &of_size);
    how->size = of_size.size;
    how->size_at = of_size.size_at;
    how->size_user = of_size.size_user;
    if (is_given(j, "--gradation") && (is_given(j, "--size") || !adds_points(j))) {
        return fail(j, "--gradation is for --ratio, --volume or --volumes without --size");
    }
    how->growth = number_of(j, "--gradation", 0);
    how->ratio = number_of(j, "--ratio", 0);
    how->volume = number_of(j, "--volume", 0);
    if (is_given(j, "--volumes")) {
        if (seeds->region_count == 0) {
            return fail(j, "%s: --volumes: the file has no regions", j->input);
        }
        how->volumes = seeds->volumes;
        how->volume_count = seeds->region_count;
    }
    return failed;
}

static int run(job *j)
{
    pbw_fill_input input;
    pbw_fill_options how;
    pbw_fill_report report;
    pbw_filled filled;
    pbw_status status;
    naming names;
    seeding seeds;
    size_t i;
    sizing sizes;
    int failed = load_sizes(j, "--size", 0);
    failed = failed ? failed : complete_faces(j);
    if (failed) {
        return failed;
    }
    memset(&input, 0, sizeof input);
    input.points = j->cloud.points;
    input.point_count = j->cloud.count;
    input.triangles = j->cloud.triangles;
    input.triangle_count = j->cloud.triangle_count;
    input.numbers = j->cloud.triangle_groups;
    input.segments = j->cloud.segments;
    input.segment_count = j->cloud.segment_count;
    memset(&seeds, 0, sizeof seeds);
    if (j->cloud.seed_count > 0 && !take_seeds(&j->cloud, &seeds)) {
        free_seeds(&seeds);
        return fail(j, "out of memory");
    }
    input.seeds = seeds.places;
    input.seed_count = seeds.count;
    input.seed_regions = seeds.regions;
    memset(&how, 0, sizeof how);
    how.conforming = is_given(j, "--conforming");
    how.split_flat = is_given(j, "--split-flat") || is_given(j, "--faces");
    how.nested = is_given(j, "--nested") || pbwio_format_of(j->input) == PBWIO_POLY;
    how.outside = is_given(j, "--outside");
    how.most = (size_t)number_of(j, "--most", 0);
    how.improve.target = number_of(j, "--target", 0);
    how.improve.seconds = number_of(j, "--seconds", 0);
    how.stage = &j->stage;
    failed = set_inside(j, &seeds, &sizes, &how);
    if (failed) {
        free_seeds(&seeds);
        return failed;
    }
    status = pbw_fill(&input, &how, &j->build, &filled, &report);
    free_sizes(&sizes);
    if (status != PBW_OK) {
        free_seeds(&seeds);
        return refuse(j, status, &report);
    }
    report_on(j, &filled, &report);
    report_regions(j, &filled, &seeds);
    memset(&names, 0, sizeof names);
    failed = name_groups(j, &filled, &seeds, &names) ? write_filled(j, &filled, &names)
           : fail(j, "out of memory");
    for (i = 0; i < names.all; i++) {
        free(names.groups[i].name);
    }
    free(names.groups);
    free(names.patches);
    free(names.regions);
    free_seeds(&seeds);
    pbw_fill_free(&filled);
    memset(&j->mesh, 0, sizeof j->mesh);
    return failed;
}

const command command_fill = {
    .name = "fill",
    .summary = "fill a surface with tetrahedra that keep its own triangles",
    .usage =
    "usage: pbw fill [options] model [-o output]...\n"
    "\n"
    "Fills a closed surface, of one or several shells, with tetrahedra that have its triangles for facets, no more,\n"
    "no fewer; a triangle on which other points of the model lie is several facets.  Points are added inside where\n"
    "that is needed.  Walls inside, open or closed, bound regions or are kept as they are; so are segments and\n"
    "points of the model.  With --conforming it is the constrained Delaunay triangulation, with points added on\n"
    "edges.\n"
    "Surfaces that cross themselves are refused, and the first places listed: pbw solid and pbw wrap take them.\n"
    "Angles may be small: --target raises them where the faces let it; pbw solid makes good tetrahedra near the\n"
    "surface.\n"
    "\n"
    "for those who come from TetGen:\n"
    "  -pY     pbw fill            -q1.4   --ratio 1.4; --target 20 for dihedral angles\n"
    "  -p      --conforming        -a0.1   --volume 0.1; -a with bounds in the file: --volumes\n"
    "  -pA     regions are always told, in the files and by their volumes here\n"
    "  -i      points of the model that are in no face are kept\n"
    "With --ratio or --volume faces get no points: tetrahedra at them may be slimmer or larger, and are counted.\n"
    "\n"
    "input:   .obj .ply .stl .off .vtu .msh with faces; .poly .smesh of TetGen, with holes and regions: what\n"
    "         is enclosed and no hole is kept\n"
    "output:  .vtu .msh .msh2 .mesh .inp .su2 .node .ele .neigh .face (tetrahedra, facets), .obj .ply .stl .off\n"
    "         (boundary), .svg (picture), .html (page to look around in); any number of them\n"
    "\n",
    .writes = "vtu msh msh2 mesh inp su2 node ele neigh face obj ply stl off svg html",
    .options = { fill_options, look_options, build_options, output_options, text_options, common_options, NULL },
    .run = run,
};
