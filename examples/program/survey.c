/* survey.c: what the triangulation of a domain's points and segments tells, before anything is cut off or refined:
   the regions of features, holes, open ends.
   In: a domain.  Out: its own triangulation up to the hull; regions, holes; messages. */
#include "domain.h"

/* Whether the ring or line that a segment is of bounds areas. */
static int bounds(const plan *d, size_t segment)
{
    const segment_kind kind = d->sources[segment].kind;
    return kind == RING || (kind == CLOSED_LINE && d->polygon_count == 0);
}

pbw_status make_domain(const plan *d, const pbw_plane_options *options, pbw_plane *plane)
{
    pbw_plane_input input;
    pbw_index *doubled = NULL, *ids = NULL;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, n = d->segment_count;
    memset(&input, 0, sizeof input);
    memset(plane, 0, sizeof *plane);
    input.points = d->points;
    input.point_count = d->point_count;
    input.segments = d->segments;
    input.holes = d->holes;
    input.hole_count = d->hole_count;
    input.regions = d->regions;
    input.region_count = d->region_count;
    input.sizes = d->sizes;
    if (d->line_count > 0) {                         /* there and back: what bounds nothing winds around nothing */
        doubled = (pbw_index *)malloc((n + 1) * 4 * sizeof *doubled);
        ids = (pbw_index *)malloc((n + 1) * 2 * sizeof *ids);
        input.segments = doubled;
        input.segment_ids = ids;
    }
    for (i = 0; doubled != NULL && ids != NULL && i < d->segment_count; i++) {
        memcpy(doubled + 2 * i, d->segments + 2 * i, 2 * sizeof *doubled);
        ids[i] = (pbw_index)i;
        if (!bounds(d, i)) {
            doubled[2 * n] = d->segments[2 * i + 1];
            doubled[2 * n + 1] = d->segments[2 * i];
            ids[n++] = (pbw_index)i;
        }
    }
    input.segment_count = n;
    if (d->line_count == 0 || (doubled != NULL && ids != NULL)) {
        status = pbw_plane_make(&input, options, plane);
    } else {
        snprintf(plane->what, sizeof plane->what, "out of memory");
    }
    free(doubled);
    free(ids);
    return status;
}

pbw_status survey(const plan *d, const pbw_plane_options *options, pbw_plane *hull)
{
    pbw_plane_options own = *options;
    own.flags &= PBW_PLANE_SPLIT_CROSSINGS;
    own.rule = PBW_PLANE_HULL;
    return make_domain(d, &own, hull);
}

/* ---- regions of features: a walk over the triangles from outside, which counts what it crosses ---- */

typedef struct area {                                /* of the plane, which segments separate from others */
    int winding, open;                               /* open: it reaches the outside without crossing a segment */
    pbw_index top, next;                             /* the last two features around it, from 1; 0: none */
    double size, x, y;                               /* of its largest triangle, and the middle of that */
} area;

typedef struct walker {
    const plan *d;
    const pbw_plane *hull;
    unsigned char *entry, *tried;                    /* per triangle: the side by which it was entered, 3: not yet;
                                                        how many sides were tried */
    pbw_index *inside;                               /* a tree of features: leaf i has i + 1 if feature i is around
                                                        the current triangle, else 0; a node the larger of its two */
    size_t leaves;
    int winding;
    area *areas;
} walker;

static void toggle(walker *w, size_t feature)
{
    size_t i = w->leaves + feature;
    w->inside[i] = w->inside[i] == 0 ? (pbw_index)feature + 1 : 0;
    for (i /= 2; i > 0; i /= 2) {
        w->inside[i] = w->inside[2 * i] > w->inside[2 * i + 1] ? w->inside[2 * i] : w->inside[2 * i + 1];
    }
}

/* Crosses side k of a triangle, way 1: into it, -1: out of it. */
static void cross(walker *w, size_t t, size_t k, int way)
{
    const pbw_plane *p = w->hull;
    const pbw_index edge = p->constraints[3 * t + k];
    const double *u = p->points + 2 * (size_t)p->triangles[3 * t + (k + 1) % 3];
    const double *v = p->points + 2 * (size_t)p->triangles[3 * t + (k + 2) % 3];
    size_t i;
    if (edge == PBW_NONE) {
        return;
    }
    for (i = p->edge_first[edge]; i < p->edge_first[edge + 1]; i++) {
        const size_t s = p->edge_segments[i];
        const double *a = w->d->points + 2 * (size_t)w->d->segments[2 * s];
        const double *b = w->d->points + 2 * (size_t)w->d->segments[2 * s + 1];
        if (bounds(w->d, s)) {
            w->winding += (v[0] - u[0]) * (b[0] - a[0]) + (v[1] - u[1]) * (b[1] - a[1]) > 0 ? way : -way;
            if (w->d->sources[s].feature != PBW_NONE) {
                toggle(w, w->d->sources[s].feature);
            }
        }
    }
}

/* Notes for the area of a triangle its middle, if that is the largest so far and rounding leaves the middle inside,
   and whether the area is open there. */
static void note_triangle(const pbw_plane *p, size_t t, area *areas)
{
    const double *a = p->points + 2 * (size_t)p->triangles[3 * t];
    const double *b = p->points + 2 * (size_t)p->triangles[3 * t + 1];
    const double *c = p->points + 2 * (size_t)p->triangles[3 * t + 2];
    const double size = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    double middle[2];
    area *at = areas + p->regions[t];
    size_t k;
    middle[0] = a[0] + ((b[0] - a[0]) + (c[0] - a[0])) / 3;
    middle[1] = a[1] + ((b[1] - a[1]) + (c[1] - a[1])) / 3;
    if (size > at->size && pbw_orient2(a, b, middle) > 0 && pbw_orient2(b, c, middle) > 0
        && pbw_orient2(c, a, middle) > 0) {
        at->size = size;
        at->x = middle[0];
        at->y = middle[1];
    }
    for (k = 0; k < 3; k++) {
        const pbw_index edge = p->constraints[3 * t + k];
        at->open |= p->neighbors[3 * t + k] == PBW_NONE
                 && (edge == PBW_NONE || p->edge_first[edge] == p->edge_first[edge + 1]);
    }
}

/* Enters a triangle by side k, and notes what is around it. */
static void enter(walker *w, size_t t, size_t k)
{
    area *at = w->areas + w->hull->regions[t];
    cross(w, t, k, 1);
    w->entry[t] = (unsigned char)k;
    note_triangle(w->hull, t, w->areas);
    at->winding = w->winding;
    at->top = w->inside[1];
    if (at->top > 0 && at->next == 0) {
        toggle(w, at->top - 1);
        at->next = w->inside[1];
        toggle(w, at->top - 1);
    }
}

/* Enters every triangle, and leaves it again; the hull has at least one. */
static void walk(walker *w)
{
    const pbw_plane *p = w->hull;
    size_t t = 0, k = 0, i;
    while (p->neighbors[3 * t + k] != PBW_NONE) {
        t += k == 2;
        k = (k + 1) % 3;
    }
    enter(w, t, k);
    for (;;) {
        const pbw_index n = w->tried[t] < 3 ? p->neighbors[3 * t + w->tried[t]] : p->neighbors[3 * t + w->entry[t]];
        if (w->tried[t] == 3) {
            cross(w, t, w->entry[t], -1);
            if (n == PBW_NONE) {
                return;
            }
            t = n;
            continue;
        }
        w->tried[t]++;
        if (n != PBW_NONE && w->entry[n] == 3) {
            for (i = 0; p->neighbors[3 * (size_t)n + i] != t; i++) {
            }
            t = n;
            enter(w, t, i);
        }
    }
}

static int add_region(plan *d, const area *at, pbw_index group)
{
    if (!grow((void **)&d->regions, d->region_count, sizeof *d->regions)
        || !grow((void **)&d->region_groups, d->region_count, sizeof *d->region_groups)) {
        return 0;
    }
    d->regions[d->region_count].x = at->x;
    d->regions[d->region_count].y = at->y;
    d->regions[d->region_count].area = 0;
    d->region_groups[d->region_count++] = group;
    return 1;
}

static int add_hole(plan *d, const area *at)
{
    if (!grow((void **)&d->holes, d->hole_count, 2 * sizeof *d->holes)) {
        return 0;
    }
    d->holes[2 * d->hole_count] = at->x;
    d->holes[2 * d->hole_count++ + 1] = at->y;
    return 1;
}

/* The regions of features that are in the domain, and a hole in each area that is not, as .poly needs them. */
static int add_seeds(plan *d, const area *areas, size_t count, pbw_plane_rule rule)
{
    size_t i;
    for (i = 0; i < count; i++) {
        const area *a = areas + i;
        const int in = rule == PBW_PLANE_EVEN_ODD ? a->winding % 2 != 0
                     : rule != PBW_PLANE_NONZERO || a->winding != 0;
        if ((in && a->top > 0 && a->size > 0 && !add_region(d, a, d->feature_groups[a->top - 1]))
            || (!in && !a->open && a->size > 0 && !add_hole(d, a))) {
            return 0;
        }
    }
    return 1;
}

/* Holes in a mesh: what its border encloses in the triangulation up to the hull. */
static int add_holes(plan *d, const pbw_plane *mesh, const pbw_plane_options *options)
{
    const size_t most = 3 * mesh->triangle_count + 1;
    pbw_index *border = (pbw_index *)malloc(2 * most * sizeof *border);
    pbw_index *left = (pbw_index *)calloc(most, sizeof *left);       /* the domain is to the left: region 0 */
    area *areas = NULL;
    pbw_plane_options own;
    pbw_plane_input input;
    pbw_plane hull;
    size_t i;
    int done = 0;
    memset(&own, 0, sizeof own);
    memset(&input, 0, sizeof input);
    memset(&hull, 0, sizeof hull);
    own.build = options->build;
    input.points = mesh->points;
    input.point_count = mesh->point_count;
    input.segments = border;
    input.segment_lefts = left;
    for (i = 0; border != NULL && i < 3 * mesh->triangle_count; i++) {
        if (mesh->neighbors[i] == PBW_NONE) {
            border[2 * input.segment_count] = mesh->triangles[i / 3 * 3 + (i + 1) % 3];
            border[2 * input.segment_count++ + 1] = mesh->triangles[i / 3 * 3 + (i + 2) % 3];
        }
    }
    if (border != NULL && left != NULL && pbw_plane_make(&input, &own, &hull) == PBW_OK) {
        areas = (area *)calloc(hull.region_count + 1, sizeof *areas);
        done = areas != NULL;
    }
    for (i = 0; done && i < hull.triangle_count; i++) {
        note_triangle(&hull, i, areas);
    }
    for (i = 0; done && i < hull.region_count; i++) {
        done = hull.region_seeds[i] != PBW_NONE || areas[i].open || !(areas[i].size > 0) || add_hole(d, areas + i);
    }
    pbw_plane_free(&hull);
    free(areas);
    free(border);
    free(left);
    return done;
}

int seed_mesh(const job *j, plan *d, const pbw_plane *mesh, const pbw_index *groups, const pbw_plane_options *options)
{
    area *areas = (area *)calloc(mesh->region_count + 1, sizeof *areas);
    size_t i, thin = 0;
    int done = areas != NULL;
    for (i = 0; done && i < mesh->triangle_count; i++) {
        note_triangle(mesh, i, areas);
        areas[mesh->regions[i]].top = groups[i];
    }
    for (i = 0; done && d->has_groups && i < mesh->region_count; i++) {
        thin += !(areas[i].size > 0);
        done = !(areas[i].size > 0) || areas[i].top == PBW_NONE || add_region(d, areas + i, areas[i].top);
    }
    if (thin > 0) {
        warn(j, "%s: %zu region%s too thin for a point inside, as .poly needs one", j->input, thin,
             thin == 1 ? " is" : "s are");
    }
    free(areas);
    return done && add_holes(d, mesh, options) ? 0 : fail(j, "out of memory");
}

/* Features that lie in one another. */
static void warn_of_overlaps(const job *j, const area *areas, size_t count, pbw_plane_rule rule)
{
    const area *first = NULL;
    char who[80] = "rings";
    size_t i, overlaps = 0;
    for (i = 0; i < count; i++) {
        if (areas[i].winding > 1 || areas[i].winding < -1) {
            first = overlaps++ == 0 ? areas + i : first;
        }
    }
    if (overlaps == 0) {
        return;
    }
    if (first->next > 0) {
        snprintf(who, sizeof who, "features %lu and %lu", (unsigned long)first->next, (unsigned long)first->top);
    }
    if (rule == PBW_PLANE_EVEN_ODD) {
        warn(j, "%s: %s overlap around (%.9g, %.9g)%s: what is in two of them is outside by the even-odd rule; "
             "--rule nonzero takes it in", j->input, who, first->x, first->y, overlaps > 1 ? " and elsewhere" : "");
    } else if (rule == PBW_PLANE_NONZERO && first->next > 0) {
        report_line(j, "%s overlap around (%.9g, %.9g)%s: the last one in the file names the region", who, first->x,
                    first->y, overlaps > 1 ? " and elsewhere" : "");
    }
}

int find_regions(const job *j, plan *d, const pbw_plane *hull, pbw_plane_rule rule)
{
    walker w;
    int done;
    memset(&w, 0, sizeof w);
    w.d = d;
    w.hull = hull;
    for (w.leaves = 1; w.leaves < d->feature_count; w.leaves *= 2) {
    }
    w.entry = (unsigned char *)malloc(hull->triangle_count + 1);
    w.tried = (unsigned char *)calloc(hull->triangle_count + 1, 1);
    w.inside = (pbw_index *)calloc(2 * w.leaves, sizeof *w.inside);
    w.areas = (area *)calloc(hull->region_count + 1, sizeof *w.areas);
    done = w.entry != NULL && w.tried != NULL && w.inside != NULL && w.areas != NULL;
    if (done) {
        memset(w.entry, 3, hull->triangle_count);
        walk(&w);
        done = add_seeds(d, w.areas, hull->region_count, rule);
    }
    if (done) {
        warn_of_overlaps(j, w.areas, hull->region_count, rule);
    }
    free(w.entry);
    free(w.tried);
    free(w.inside);
    free(w.areas);
    return done ? 0 : fail(j, "out of memory");
}

/* ---- faults, in words ---- */

/* A point for a message: its number, if the file has numbers, and where it is. */
static void name_point(const plan *d, const pbw_plane *hull, size_t i, char *out, size_t room)
{
    const double *x = hull->points + 2 * i;
    if (d->has_seeds && i < d->point_count) {
        snprintf(out, room, "point %zu (%.9g, %.9g)", i + (size_t)d->base, x[0], x[1]);
    } else {
        snprintf(out, room, "(%.9g, %.9g)", x[0], x[1]);
    }
}

int nothing_enclosed(const job *j, const plan *d, const pbw_plane_options *options)
{
    pbw_plane hull;
    unsigned char *uses;
    char open[400] = "", one[80];
    size_t i, ends = 0;
    if (d->segment_count == 0) {
        return fail(j, "%s: nothing is enclosed, there are no segments; --rule hull triangulates the points",
                    j->input);
    }
    if (survey(d, options, &hull) != PBW_OK) {
        return fail(j, "%s: nothing is enclosed", j->input);
    }
    uses = (unsigned char *)calloc(hull.point_count + 1, 1);
    for (i = 0; uses != NULL && i < 2 * hull.edge_count; i++) {
        if (hull.edge_first[i / 2] < hull.edge_first[i / 2 + 1] && uses[hull.edges[i]] < 2) {
            uses[hull.edges[i]]++;
        }
    }
    for (i = 0; uses != NULL && i < hull.point_count; i++) {
        if (uses[i] == 1 && ends++ < 4) {
            name_point(d, &hull, i, one, sizeof one);
            snprintf(open + strlen(open), sizeof open - strlen(open), "%s%s", ends > 1 ? ", " : "", one);
        }
    }
    free(uses);
    pbw_plane_free(&hull);
    return ends == 0
         ? fail(j, "%s: nothing is enclosed: holes, or rings that lie on each other, take all; --rule hull "
                "triangulates all", j->input)
         : fail(j, "%s: nothing is enclosed: segments end where no other goes on, at %s%s; close the outline, or "
                "--rule hull triangulates all", j->input, open, ends > 4 ? " and so on" : "");
}

/* Where two segments cross. */
static void place_of(const plan *d, size_t s, size_t t, double out[2])
{
    const double *a = d->points + 2 * (size_t)d->segments[2 * s], *b = d->points + 2 * (size_t)d->segments[2 * s + 1];
    const double *u = d->points + 2 * (size_t)d->segments[2 * t], *v = d->points + 2 * (size_t)d->segments[2 * t + 1];
    const double x = b[0] - a[0], y = b[1] - a[1], twice = x * (v[1] - u[1]) - y * (v[0] - u[0]);
    const double share = ((u[0] - a[0]) * (v[1] - u[1]) - (u[1] - a[1]) * (v[0] - u[0])) / twice;
    out[0] = a[0] + share * x;
    out[1] = a[1] + share * y;
}

int crossing(const job *j, const plan *d, const pbw_plane *plane)
{
    const size_t s = plane->crossings[0], t = plane->crossings[1];
    const source *one = d->sources != NULL ? d->sources + s : NULL;
    const source *other = d->sources != NULL ? d->sources + t : NULL;
    char who[120], more[60] = "";
    double x[2];
    place_of(d, s, t, x);
    if (one == NULL) {                               /* of a mesh: no lines are known */
        snprintf(who, sizeof who, "segments");
    } else if (d->has_seeds) {
        snprintf(who, sizeof who, "segments %zu and %zu (lines %zu and %zu)", s + (size_t)d->base,
                 t + (size_t)d->base, one->line, other->line);
    } else if (one->feature != PBW_NONE && other->feature != PBW_NONE && one->feature != other->feature) {
        snprintf(who, sizeof who, "features %lu and %lu (lines %zu and %zu)", (unsigned long)one->feature + 1,
                 (unsigned long)other->feature + 1, one->line, other->line);
    } else if (one->feature != PBW_NONE) {
        snprintf(who, sizeof who, "segments of feature %lu (lines %zu and %zu)", (unsigned long)one->feature + 1,
                 one->line, other->line);
    } else {
        snprintf(who, sizeof who, "segments (lines %zu and %zu)", one->line, other->line);
    }
    if (plane->crossing_count > 1) {
        snprintf(more, sizeof more, "; crossings in all: %zu", plane->crossing_count);
    }
    return fail(j, "%s: %s cross at (%.9g, %.9g)%s; --split-crossings puts points there", j->input, who, x[0], x[1],
                more);
}
