/* plane.c: pbw plane.
   In: a plane domain.  Out: its triangles, with what its points, segments and regions carry, and a report. */
#include "domain.h"

static const char *const rules[] = { "hull", "seeds", "even-odd", "nonzero", NULL };

static const option plane_options[] = {
    { "--angle", "DEGREES", "refine: no smaller angle, up to 34, but at small angles of the input", POSITIVE, 0, 34,
      NULL },
    { "--area", "A", "refine: no larger triangle", POSITIVE, 0, 0, NULL },
    OPTION_SIZE("at most"),
    OPTION_GRADATION("most growth of sizes per distance: of a column, default 0.3; of a formula and of the\n"
                     "areas of regions, default any"),
    { "--coarsen", NULL, "leave points out that are nearer to each other than half of --size", SWITCH, 0, 0, NULL },
    OPTION_SMOOTH("move points to better means: laplace, lloyd or odt"),
    OPTION_ROUNDS("of --smooth, default 5"),
    { "--split-crossings", NULL, "put points where segments cross, instead of an error", SWITCH, 0, 0, NULL },
    { "--rule", "RULE", "what belongs to the domain: hull (all), seeds (what segments enclose, but holes),\n"
      "even-odd, nonzero (by winding numbers); default: .poly seeds, .geojson with\n"
      "polygons even-odd, else hull", CHOICE, 0, 0, rules },
    { "--region-by", "NAME", ".geojson: the property of features that names their regions: whole numbers are tags,\n"
      "strings are names; default: each feature is a region, with its number from 1", PLAIN, 0, 0, NULL },
    { "--keep-boundary", NULL, "no new points on the boundary", SWITCH, 0, 0, NULL },
    { "--keep-segments", NULL, "no new points on segments", SWITCH, 0, 0, NULL },
    OPTION_CONFORMING("all triangles Delaunay, across segments too"),
    { "--steiner", "N", "at most N new points", WHOLE, 1, 4e9, NULL },
    OPTION_MOST("triangles"),
    OPTION_NO_ORPHANS,
    OPTION_QUALITY,
    { "--histogram", NULL, "print how many triangles have which least angle", SWITCH, 0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

typedef struct result {
    const plan *plan;
    pbw_plane *plane;
    pbw_index *origin;                               /* per point: the point of the plan that it is, or PBW_NONE */
    carried carried;
    void *own[5];                                    /* of the plane: without orphans points, triangles, edges; see
                                                        list_groups */
    pbw_mesh mesh;                                   /* the triangles as a mesh, for what writes meshes */
    double *least;                                   /* per triangle: its least angle */
    double least_angle, largest_angle;               /* of all */
    unsigned char *on_segment;                       /* per point */
} result;

static double size_at(void *user, double x, double y)
{
    const char *wrong;
    const double at[2] = { x, y }, value = evaluate((const char *)user, 2, at, &wrong);
    return value > 0 ? value : 0;
}

/* ---- the triangles as a mesh, with their angles ---- */

/* Leaves out points that are no corner, and numbers the others in their order. */
static int drop_orphans(result *r)
{
    pbw_plane *p = r->plane;
    pbw_index *number = (pbw_index *)malloc((p->point_count + 1) * sizeof *number);
    double *points = (double *)malloc((p->point_count + 1) * 2 * sizeof *points);
    pbw_index *triangles = (pbw_index *)malloc((p->triangle_count + 1) * 3 * sizeof *triangles);
    pbw_index *edges = (pbw_index *)malloc((p->edge_count + 1) * 2 * sizeof *edges);
    size_t i, kept = 0;
    r->own[0] = points;
    r->own[1] = triangles;
    r->own[2] = edges;
    if (number == NULL || points == NULL || triangles == NULL || edges == NULL) {
        free(number);
        return 0;
    }
    memset(number, 255, p->point_count * sizeof *number);
    for (i = 0; i < 3 * p->triangle_count; i++) {
        number[p->triangles[i]] = 0;
    }
    for (i = 0; i < p->point_count; i++) {
        if (number[i] == 0) {
            memcpy(points + 2 * kept, p->points + 2 * i, 2 * sizeof *points);
            r->origin[kept] = r->origin[i];
            number[i] = (pbw_index)kept++;
        }
    }
    for (i = 0; i < 3 * p->triangle_count; i++) {
        triangles[i] = number[p->triangles[i]];
    }
    for (i = 0; i < 2 * p->edge_count; i++) {
        edges[i] = number[p->edges[i]];
    }
    free(number);
    p->points = points;
    p->point_count = kept;
    p->triangles = triangles;
    p->edges = edges;
    return 1;
}

/* Returns 0 or the exit status. */
static int finish(const job *j, result *r)
{
    const pbw_plane *p = r->plane;
    pbw_index *incident = (pbw_index *)malloc((p->point_count + 1) * sizeof *incident);
    pbw_index *canonical = (pbw_index *)malloc((p->point_count + 1) * sizeof *canonical);
    size_t i, k;
    r->least = (double *)malloc((p->triangle_count + 1) * sizeof *r->least);
    r->on_segment = (unsigned char *)calloc(p->point_count + 1, 1);
    r->mesh.dim = 2;
    r->mesh.point_count = p->point_count;
    r->mesh.simplex_count = p->triangle_count;
    r->mesh.simplices = p->triangles;
    r->mesh.neighbors = p->neighbors;
    r->mesh.points = p->points;
    r->mesh.incident = incident;
    r->mesh.canonical = canonical;
    if (incident == NULL || canonical == NULL || r->least == NULL || r->on_segment == NULL) {
        return fail(j, "out of memory");
    }
    r->least_angle = 180;
    for (i = 0; i < p->point_count; i++) {
        incident[i] = PBW_NONE;
        canonical[i] = (pbw_index)i;
    }
    for (i = p->triangle_count; i > 0; i--) {
        const pbw_index *v = p->triangles + 3 * (i - 1);
        const double *a = p->points + 2 * (size_t)v[0], *b = p->points + 2 * (size_t)v[1];
        const double *c = p->points + 2 * (size_t)v[2];
        const size_t done = p->triangle_count - i;
        if (done % 65536 == 0 && draw_bar(j, "measure", (double)done / (double)p->triangle_count)) {
            return stopped(j);
        }
        r->least[i - 1] = pbw_plane_measure_of(PBW_PLANE_MIN_ANGLE, a, b, c);
        r->largest_angle = fmax(r->largest_angle, pbw_plane_measure_of(PBW_PLANE_MAX_ANGLE, a, b, c));
        for (k = 0; k < 3; k++) {
            incident[v[k]] = (pbw_index)(i - 1);
        }
        r->least_angle = fmin(r->least_angle, r->least[i - 1]);
    }
    for (i = 0; i < 2 * p->edge_count; i++) {
        r->on_segment[p->edges[i]] = 1;
    }
    return 0;
}

static void finish_free(result *r)
{
    int i;
    free((void *)(uintptr_t)r->mesh.incident);
    free((void *)(uintptr_t)r->mesh.canonical);
    free(r->least);
    free(r->on_segment);
    free(r->origin);
    for (i = 0; i < 5; i++) {
        free(r->own[i]);
    }
    carried_free(&r->carried);
}

/* ---- report ---- */

static void histogram(const job *j, const result *r)
{
    size_t bin[13] = { 0 }, most = 1, i;
    for (i = 0; i < r->plane->triangle_count; i++) {
        const int b = (int)(r->least[i] / 5);
        bin[b < 0 ? 0 : b > 12 ? 12 : b]++;
    }
    for (i = 0; i < 12; i++) {
        most = bin[i] > most ? bin[i] : most;
    }
    for (i = 0; i < 12; i++) {
        report_line(j, "  %2zu..%-2zu %10zu %.*s", 5 * i, 5 * i + 5, bin[i], (int)(40 * bin[i] / most),
                    "########################################");
    }
}

void describe_plane_measures(const job *j, const pbw_plane *plane)
{
    int i;
    for (i = 0; i < PBW_PLANE_MEASURES; i++) {
        pbw_plane_quality q;
        (void)draw_bar(j, "measure", (double)i / PBW_PLANE_MEASURES);
        q = pbw_plane_quality_of(plane, (pbw_plane_measure)i);
        report_line(j, "%-16s least %.7g, mean %.7g, most %.7g", pbw_plane_measure_name((pbw_plane_measure)i),
                    q.least, q.mean, q.most);
    }
}

static void report(const job *j, const result *r, double seconds)
{
    const pbw_plane *p = r->plane;
    report_step(j, "mesh", seconds, "%s", "");
    report_line(j, "%zu triangle%s, %zu point%s, %zu edge%s of segments, %zu region%s", COUNT(p->triangle_count),
                COUNT(p->point_count), COUNT(p->edge_count), COUNT(p->region_count));
    if (p->triangle_count > 0) {
        report_line(j, "angles from %.2f to %.2f degrees", r->least_angle, r->largest_angle);
    }
    if (p->report.rounds > 0) {
        report_line(j, "%zu point%s at crossings, in %zu round%s",
                    COUNT(p->point_count - p->input_count - p->report.steiner_count), COUNT(p->report.rounds));
    }
    if (p->report.steiner_count + p->report.small_angles + p->report.too_large > 0) {
        report_line(j, "%zu new point%s, %zu more removed again; %zu triangle%s with smaller angles than wanted, "
                    "%zu larger%s", COUNT(p->report.steiner_count), p->report.removed, COUNT(p->report.small_angles),
                    p->report.too_large,
                    p->report.limited ? "; --steiner ended it" : "");
    }
    if (is_given(j, "--quality") && p->triangle_count > 0) {
        describe_plane_measures(j, p);
    }
    if (is_given(j, "--histogram")) {
        histogram(j, r);
    }
}

/* ---- outputs ---- */

/* The marker of an edge or point in a .poly file. */
static long long marker_of(const carried *c, const pbw_index *groups, const int *markers, size_t i)
{
    return groups == NULL ? markers[i] : groups[i] == PBW_NONE ? 0 : c->groups[groups[i]].tag;
}

static void emit_poly(void *user, FILE *file)
{
    const result *r = (const result *)user;
    const pbw_plane *p = r->plane;
    const carried *c = &r->carried;
    const size_t base = (size_t)r->plan->base;
    size_t i, k;
    fprintf(file, "%zu 2 %zu 1\n", p->point_count, c->column_count + (c->heights != NULL));
    for (i = 0; i < p->point_count; i++) {
        fprintf(file, "%zu %.17g %.17g", i + base, p->points[2 * i], p->points[2 * i + 1]);
        for (k = 0; k < c->column_count; k++) {
            fprintf(file, " %.17g", c->columns[k].values[i]);
        }
        if (c->heights != NULL) {
            fprintf(file, " %.17g", c->heights[i]);
        }
        fprintf(file, " %lld\n", marker_of(c, c->point_groups, c->point_markers, i));
    }
    fprintf(file, "%zu 1\n", p->edge_count);
    for (i = 0; i < p->edge_count; i++) {
        fprintf(file, "%zu %zu %zu %lld\n", i + base, p->edges[2 * i] + base, p->edges[2 * i + 1] + base,
                marker_of(c, c->edge_groups, c->edge_markers, i));
    }
    fprintf(file, "%zu\n", r->plan->hole_count);
    for (i = 0; i < r->plan->hole_count; i++) {
        fprintf(file, "%zu %.17g %.17g\n", i + base, r->plan->holes[2 * i], r->plan->holes[2 * i + 1]);
    }
    fprintf(file, "%zu\n", r->plan->region_count);
    for (i = 0; i < r->plan->region_count; i++) {
        const pbw_plane_region *region = r->plan->regions + i;
        const pbw_index group = r->plan->region_groups[i];
        fprintf(file, "%zu %.17g %.17g %lld %.17g\n", i + base, region->x, region->y,
                group == PBW_NONE ? 0 : r->plan->groups[group].tag, region->area > 0 ? region->area : -1);
    }
}

/* A colour for a region, paler where the least angle is larger. */
static unsigned colour(unsigned region, double least)
{
    static const unsigned char base[6][3] = { { 66, 133, 180 }, { 221, 132, 82 }, { 85, 160, 104 }, { 196, 78, 82 },
                                              { 129, 114, 178 }, { 147, 120, 96 } };
    const double pale = 0.15 + 0.6 * fmin(least, 60) / 60;
    unsigned c = 0;
    int k;
    for (k = 0; k < 3; k++) {
        c = c << 8 | (unsigned)(base[region % 6][k] + pale * (255 - base[region % 6][k]));
    }
    return c;
}

static void emit_svg(void *user, FILE *file)
{
    const result *r = (const result *)user;
    const pbw_plane *p = r->plane;
    double low[2] = { HUGE_VAL, HUGE_VAL }, high[2] = { -HUGE_VAL, -HUGE_VAL }, scale;
    size_t i, k;
    for (i = 0; i < 3 * p->triangle_count; i++) {
        for (k = 0; k < 2; k++) {
            low[k] = fmin(low[k], p->points[2 * (size_t)p->triangles[i] + k]);
            high[k] = fmax(high[k], p->points[2 * (size_t)p->triangles[i] + k]);
        }
    }
    scale = 1000 / fmax(fmax(high[0] - low[0], high[1] - low[1]), 1e-300);
    fprintf(file, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-10 -10 %.0f %.0f\">\n"
            "<g stroke=\"#333\" stroke-width=\".3\" stroke-linejoin=\"round\">\n", (high[0] - low[0]) * scale + 20,
            (high[1] - low[1]) * scale + 20);
    for (i = 0; i < p->triangle_count; i++) {
        fprintf(file, "<path fill=\"#%06x\" d=\"", colour(p->regions[i], r->least[i]));
        for (k = 0; k < 3; k++) {
            const double *q = p->points + 2 * (size_t)p->triangles[3 * i + k];
            fprintf(file, "%c%.6g %.6g", k == 0 ? 'M' : 'L', (q[0] - low[0]) * scale, (high[1] - q[1]) * scale);
        }
        fputs("z\"/>\n", file);
    }
    fputs("</g>\n<path fill=\"none\" stroke=\"#111\" stroke-width=\"1.6\" stroke-linecap=\"round\" d=\"", file);
    for (i = 0; i < 2 * p->edge_count; i++) {
        const double *q = p->points + 2 * (size_t)p->edges[i];
        fprintf(file, "%c%.6g %.6g\n", i % 2 == 0 ? 'M' : 'L', (q[0] - low[0]) * scale, (high[1] - q[1]) * scale);
    }
    fputs("\"/>\n</svg>\n", file);
}

static pbwio_status write_page(const job *j, const char *path, const result *r, pbwio_error *error)
{
    pbwview_options view;
    pbwview_array arrays[4];
    uint32_t *on = (uint32_t *)malloc((r->mesh.point_count + 1) * sizeof *on);
    pbwio_status status = PBWIO_ERROR_MEMORY;
    size_t i;
    memset(&view, 0, sizeof view);
    memset(arrays, 0, sizeof arrays);
    snprintf(error->text, sizeof error->text, "out of memory");
    for (i = 0; on != NULL && i < r->mesh.point_count; i++) {
        on[i] = r->on_segment[i];
    }
    arrays[0].name = "least angle";
    arrays[0].real = r->least;
    arrays[1].name = "region";
    arrays[1].whole = r->plane->regions;
    arrays[1].classes = 1;
    arrays[2].name = "on segments";
    arrays[2].whole = on;
    arrays[2].of_points = arrays[2].classes = 1;
    arrays[3].name = "height";
    arrays[3].real = r->carried.heights;
    arrays[3].of_points = 1;
    view.title = j->input;
    view.arrays = arrays;
    view.array_count = r->carried.heights != NULL ? 4 : 3;
    view.colour = r->plane->region_count > 1 ? "region" : "least angle";
    if (on != NULL) {
        status = pbwview_write(path, &r->mesh, &view, error);
    }
    free(on);
    return status;
}

static pbwio_status write_one(job *j, const char *path, const char *ending, void *user, pbwio_error *error)
{
    result *r = (result *)user;
    char name[16];
    if (strcmp(ending, "poly") == 0) {
        return pbwio_save(path, emit_poly, r, &j->build, error);
    }
    if (strcmp(ending, "svg") == 0) {
        return pbwio_save(path, emit_svg, r, &j->build, error);
    }
    if (strcmp(ending, "html") == 0) {
        return write_page(j, path, r, error);
    }
    if (strcmp(ending, "geojson") == 0) {
        return write_triangles(path, &r->mesh, &j->write, error);
    }
    snprintf(name, sizeof name, "a.%s", ending);
    j->write.format = pbwio_format_of(name);
    return pbwio_write(path, &r->mesh, &j->write, error);
}

/* ---- the command ---- */

/* Whether the domain is that of the input's triangles. */
static int is_of_mesh(const job *j, const plan *d)
{
    return d->triangle_count > 0 && !is_given(j, "--rule");
}

static int set_up(const job *j, const plan *d, pbw_plane_options *options)
{
    static const pbw_plane_rule of[] = { PBW_PLANE_HULL, PBW_PLANE_SEEDS, PBW_PLANE_EVEN_ODD, PBW_PLANE_NONZERO };
    const char *size = text_of(j, "--size");
    const int rule = choice_of(j, "--rule");
    memset(options, 0, sizeof *options);
    options->rule = rule >= 0 ? of[rule] : d->has_windings ? PBW_PLANE_EVEN_ODD : d->has_seeds ? PBW_PLANE_SEEDS
                  : PBW_PLANE_HULL;
    options->angle = number_of(j, "--angle", -1);
    options->area = number_of(j, "--area", 0);
    options->gradation = number_of(j, "--gradation", 0);
    options->steiner_limit = (size_t)number_of(j, "--steiner", 0);
    options->most = number_of(j, "--most", 0);
    options->build = &j->build;
    options->flags = (is_given(j, "--split-crossings") ? PBW_PLANE_SPLIT_CROSSINGS : 0)
                   | (is_given(j, "--keep-boundary") ? PBW_PLANE_KEEP_BOUNDARY : 0)
                   | (is_given(j, "--keep-segments") ? PBW_PLANE_KEEP_SEGMENTS : 0)
                   | (is_given(j, "--conforming") ? PBW_PLANE_REFINE | PBW_PLANE_CONFORMING : 0)
                   | (is_given(j, "--angle") || is_given(j, "--area") || size != NULL ? PBW_PLANE_REFINE : 0);
    if (size != NULL && size_column(size) == NULL) {
        options->size_at = size_at;
        options->size_user = (void *)(uintptr_t)size;
    }
    return check_sizes(j, "--size", 2);
}

/* Makes a plane finer and coarser by sizes at its points: a column of the input, or a formula. */
static pbw_status adapt(const job *j, const plan *d, const pbw_plane_options *options, pbw_plane *plane,
                        pbw_index *from)
{
    const size_t n = plane->point_count;
    double *sizes = (double *)malloc((n + 1) * sizeof *sizes);
    unsigned char *keep = points_to_keep(d, n, NULL);
    pbw_plane next;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i;
    memset(&next, 0, sizeof next);
    snprintf(next.what, sizeof next.what, "out of memory");
    for (i = 0; sizes != NULL && i < n; i++) {
        const double *x = plane->points + 2 * i;
        sizes[i] = d->sizes == NULL ? size_at(options->size_user, x[0], x[1]) : i < d->point_count ? d->sizes[i] : 0;
    }
    if (sizes != NULL && keep != NULL) {
        if (!is_given(j, "--coarsen")) {
            memset(keep, 1, n);
        }
        status = pbw_plane_adapt(plane, sizes, keep, options, &next, from);
    }
    free(sizes);
    free(keep);
    pbw_plane_free(plane);
    *plane = next;
    return status;
}

/* own: see list_groups. */
static pbw_status make_plane(const job *j, const plan *d, const pbw_plane_options *options, pbw_plane *plane,
                             pbw_index **origin, void *own[2])
{
    const int of_mesh = is_of_mesh(j, d), way = choice_of(j, "--smooth");
    const int adapts = is_given(j, "--coarsen") || (of_mesh && d->sizes != NULL);
    pbw_plane_options first = *options;
    pbw_index *from = NULL;
    pbw_status status;
    first.flags &= adapts ? ~(PBW_PLANE_REFINE | PBW_PLANE_CONFORMING) : ~0u;
    status = of_mesh ? make_again(d, &first, plane) : make_domain(d, &first, plane);
    if (status == PBW_OK && plane->triangle_count > 0) {
        warn_of_losses(j, d, plane);
    }
    if (status == PBW_OK && d->sources == NULL && !list_groups(d, plane, own)) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK && adapts && plane->triangle_count > 0) {
        from = (pbw_index *)malloc((plane->point_count + 1) * sizeof *from);
        status = from != NULL ? adapt(j, d, options, plane, from) : PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK && !find_origins(d, plane, from, origin)) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK && way >= 0 && plane->triangle_count > 0) {
        const double before = pbw_plane_quality_of(plane, PBW_PLANE_MIN_ANGLE).mean;
        status = smooth(d, plane, *origin, (pbw_plane_way)way, (int)number_of(j, "--rounds", 5), options);
        report_line(j, "smoothed: mean of least angles from %.2f to %.2f degrees", before,
                    pbw_plane_quality_of(plane, PBW_PLANE_MIN_ANGLE).mean);
    }
    free(from);
    return status;
}

/* The mesh of the domain, with what that carries.  own: see carry. */
static int make_result(job *j, const plan *d, const pbw_plane_options *options, const pbw_plane *own, result *r)
{
    const double start = now();
    pbw_status status = make_plane(j, d, options, r->plane, &r->origin, r->own + 3);
    if (status == PBW_OK && r->plane->triangle_count == 0) {
        return nothing_enclosed(j, d, options);
    }
    if (status == PBW_OK && d->triangle_groups != NULL && !is_of_mesh(j, d)) {
        warn(j, "%s: --rule takes points and segments alone: the regions of triangles are left out", j->input);
    }
    if (status == PBW_OK && is_given(j, "--no-orphans") && !drop_orphans(r)) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        status = carry(j, d, own, r->plane, r->origin, &r->carried);
    }
    if (status != PBW_OK) {
        return status == PBW_CANCELLED ? stopped(j)
             : r->plane->crossing_count > 0 && d->segment_count > 0 && !is_of_mesh(j, d) ? crossing(j, d, r->plane)
             : status == PBW_ERROR_TOO_LARGE && r->plane->report.estimate > number_of(j, "--most", 5e7)
             ? fail(j, "%s: about %.3g triangles, more than --most allows; larger sizes or a smaller angle need "
                    "fewer", j->input, r->plane->report.estimate)
             : fail(j, "%s%s%s", is_of_mesh(j, d) ? j->input : "", is_of_mesh(j, d) ? ": " : "",
                    r->plane->what[0] != 0 ? r->plane->what : pbw_status_string(status));
    }
    if (finish(j, r) != 0) {
        return FAILURE;
    }
    report(j, r, now() - start);
    return 0;
}

/* The triangulation that columns and heights are linear in, and features are found in; if there are some. */
static int make_own(job *j, plan *d, const pbw_plane_options *options, pbw_plane *own, pbw_index **corners)
{
    const int carries = d->heights != NULL || d->column_count > 0;
    pbw_status status;
    if (carries && !unify_duplicates(j, d)) {
        return fail(j, "out of memory");
    }
    if (d->triangle_count > 0 && carries) {
        return view_triangles(d, own, corners) ? 0 : fail(j, "out of memory");
    }
    if (!carries && d->polygon_count == 0) {
        return 0;
    }
    status = survey(d, options, own);
    if (status != PBW_OK) {
        return status == PBW_CANCELLED ? stopped(j) : own->crossing_count > 0 ? crossing(j, d, own)
             : fail(j, "%s: %s", j->input, own->what);
    }
    return d->polygon_count > 0 ? find_regions(j, d, own, options->rule) : 0;
}

static int make(job *j, plan *d, const pbw_plane_options *options)
{
    pbw_plane plane, own;
    pbw_index *corners = NULL;
    result r;
    int failed, i;
    memset(&r, 0, sizeof r);
    memset(&plane, 0, sizeof plane);
    memset(&own, 0, sizeof own);
    r.plan = d;
    r.plane = &plane;
    failed = make_own(j, d, options, &own, &corners);
    failed = failed ? failed : make_result(j, d, options, own.triangle_count > 0 && (d->heights != NULL
                                           || d->column_count > 0) ? &own : NULL, &r);
    for (i = 0; i < j->outputs && !failed && d->sources == NULL && d->triangle_count + d->segment_count > 0; i++) {
        if (strcmp(ending_of(j, j->output[i]), "poly") == 0) {
            failed = seed_mesh(j, d, &plane, r.carried.regions, options);
            break;
        }
    }
    if (!failed) {
        show_carried(&j->write, &r.carried, d->base);
        j->mesh = r.mesh;                            /* a view */
        failed = write_with(j, write_one, &r);
        memset(&j->mesh, 0, sizeof j->mesh);
    }
    finish_free(&r);
    pbw_plane_free(&plane);
    if (corners != NULL) {
        free(corners);                               /* the view of them has nothing of its own */
    } else {
        pbw_plane_free(&own);
    }
    return failed;
}

static int run(job *j)
{
    pbw_plane_options options;
    plan d;
    int failed;
    memset(&d, 0, sizeof d);
    failed = set_up(j, &d, &options);                /* before the input is read: are the options right? */
    failed = failed ? failed : read_domain(j, &d, size_column(text_of(j, "--size")));
    if (!failed) {
        failed = set_up(j, &d, &options);
    }
    if (!failed) {
        failed = make(j, &d, &options);
    }
    domain_free(&d);
    return failed;
}

const command command_plane = {
    .name = "plane",
    .summary = "triangulate and refine plane domains",
    .usage =
    "usage: pbw plane [options] domain [-o output]...\n"
    "\n"
    "The constrained Delaunay triangulation of points and segments, with holes and regions; refined if an angle,\n"
    "an area or a size is given.\n"
    "\n"
    "input:   .poly (with its .node), .geojson; points: as for pbw mesh.  Triangles in the plane, of .ele .vtu .msh\n"
    "         and so on, give their domain, which is triangulated again, with their regions, groups of edges and of\n"
    "         points, and the borders between regions; --rule takes their points and segments alone\n"
    "output:  .svg .html (regions, segments, angles), .poly, .geojson (triangles); .vtu .msh .msh2 .mesh .ele .node\n"
    "         .neigh .edge .csv .obj .ply .off .stl .inp .su2\n"
    "         Regions: data of cells in .vtu, groups in .msh and .inp, references in .msh2, .mesh and .ele.  Tags are\n"
    "         the attributes of the regions of a .poly, those of a mesh, else numbers from 1.  Names stay where formats\n"
    "         have them.  Regions and holes of a mesh are points in a .poly.  Markers of segments and points,\n"
    "         attributes and heights of points go out as they came in; at new points attributes and heights are\n"
    "         linear in between.\n"
    ".geojson: Points are points, lines are segments, rings of polygons bound the domain; what is in two polygons\n"
    "         is outside unless --rule is nonzero.  A third number is the height.  Each feature is a region.\n"
    "For those who come from Triangle: -q30 is --angle 30, -a.1 --area .1, -u --size, -p a .poly, -r a mesh as input,\n"
    "-c --rule hull, -Y --keep-boundary, -YY --keep-segments, -D --conforming, -S99 --steiner 99, -j --no-orphans;\n"
    "-A is always on.\n"
    "\n",
    .writes = "svg html poly geojson vtu msh msh2 mesh ele node neigh edge csv obj ply off stl inp su2",
    .options = { plane_options, input_options, build_options, output_options, text_options, common_options, NULL },
    .run = run,
};
