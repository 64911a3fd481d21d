/* carry.c: what the points and segments of a plane domain carry to its mesh: columns and heights, linear in the
   domain's own triangles; markers; regions.
   In: a domain, its own triangulation, its mesh, and where the points of that are from.  Out: columns, heights and
   markers of the mesh; groups. */
#include "domain.h"

/* ---- points that coincide: the first one's values count ---- */

size_t unify(const pbw_index *first, size_t count, double *values)
{
    size_t i, differ = 0;
    for (i = 0; i < count; i++) {
        differ += values[first[i]] < values[i] || values[first[i]] > values[i];
        values[i] = values[first[i]];
    }
    return differ;
}

typedef struct spot { double x, y; size_t number; } spot;

static int compare_spots(const void *one, const void *other)
{
    const spot *a = (const spot *)one, *b = (const spot *)other;
    return a->x < b->x || a->x > b->x ? (a->x > b->x) - (a->x < b->x)
         : a->y < b->y || a->y > b->y ? (a->y > b->y) - (a->y < b->y)
         : (a->number > b->number) - (a->number < b->number);
}

int unify_duplicates(const job *j, plan *d)
{
    const size_t n = d->point_count;
    spot *spots = (spot *)malloc((n + 1) * sizeof *spots);
    pbw_index *first = (pbw_index *)malloc((n + 1) * sizeof *first);
    size_t i, differ = 0, k = 0;
    const int done = spots != NULL && first != NULL;
    for (i = 0; i < n && done; i++) {
        spots[i].x = d->points[2 * i];
        spots[i].y = d->points[2 * i + 1];
        spots[i].number = i;
    }
    if (done) {
        qsort(spots, n, sizeof *spots, compare_spots);
    }
    for (i = 0; i < n && done; i++) {
        k = i > 0 && !(spots[i].x > spots[k].x) && !(spots[i].y > spots[k].y || spots[i].y < spots[k].y) ? k : i;
        first[spots[i].number] = (pbw_index)spots[k].number;
    }
    if (done && d->heights != NULL) {
        differ = unify(first, n, d->heights);
        warn_of_heights(j, differ);
    }
    for (k = 0, differ = 0; k < d->column_count && done; k++) {
        differ += unify(first, n, d->columns[k].values);
    }
    if (differ > 0) {
        warn(j, "points that coincide differ in %zu attribute%s: those of the first one count", COUNT(differ));
    }
    free(spots);
    free(first);
    return done;
}

/* ---- values ---- */

/* The values of a crossing: the mean of those along the segments through it.  values: `width` a point, 0 there. */
static int add_crossings(const plan *d, const pbw_plane *own, size_t width, double *values)
{
    size_t *count, i, k, m;
    if (own->point_count == d->point_count) {
        return 1;
    }
    count = (size_t *)calloc(own->point_count - d->point_count, sizeof *count);
    for (i = 0; count != NULL && i < 2 * own->edge_count; i++) {
        const size_t p = own->edges[i], edge = i / 2;
        for (m = own->edge_first[edge]; p >= d->point_count && m < own->edge_first[edge + 1]; m++) {
            const size_t a = d->segments[2 * (size_t)own->edge_segments[m]];
            const size_t b = d->segments[2 * (size_t)own->edge_segments[m] + 1];
            const double x = d->points[2 * b] - d->points[2 * a], y = d->points[2 * b + 1] - d->points[2 * a + 1];
            const double share = ((own->points[2 * p] - d->points[2 * a]) * x
                                  + (own->points[2 * p + 1] - d->points[2 * a + 1]) * y) / (x * x + y * y);
            for (k = 0; k < width; k++) {
                const double here = values[width * a + k];
                values[width * p + k] += here + share * (values[width * b + k] - here);
            }
            count[p - d->point_count]++;
        }
    }
    for (i = d->point_count; count != NULL && i < own->point_count; i++) {
        for (k = 0; k < width && count[i - d->point_count] > 0; k++) {
            values[width * i + k] /= (double)count[i - d->point_count];
        }
    }
    free(count);
    return count != NULL;
}

/* Columns, then heights, at the points of the mesh: those of a point of the domain that has not moved, or between. */
static pbw_status carry_values(const job *j, const plan *d, const pbw_plane *own, const pbw_plane *mesh,
                               const pbw_index *origin, carried *c)
{
    const size_t width = d->column_count + (d->heights != NULL), n = mesh->point_count;
    double *values = (double *)calloc(own->point_count * width + 1, sizeof *values);
    double *out = (double *)malloc((n * width + 1) * sizeof *out);
    pbw_plane_options options;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, k;
    memset(&options, 0, sizeof options);
    options.build = &j->build;
    for (i = 0; values != NULL && i < d->point_count; i++) {
        for (k = 0; k < width; k++) {
            values[width * i + k] = k < d->column_count ? d->columns[k].values[i] : d->heights[i];
        }
    }
    if (values != NULL && out != NULL && add_crossings(d, own, width, values)) {
        status = pbw_plane_transfer(own, mesh, values, width, out, &options);
    }
    c->columns = (pbwio_column *)calloc(d->column_count + 1, sizeof *c->columns);
    status = c->columns == NULL ? PBW_ERROR_MEMORY : status;
    for (k = 0; k < width && status == PBW_OK; k++) {
        double *column = (double *)malloc((n + 1) * sizeof *column);
        status = column == NULL ? PBW_ERROR_MEMORY : status;
        for (i = 0; column != NULL && i < n; i++) {
            const size_t old = origin[i];
            const int same = old < d->point_count && memcmp(d->points + 2 * old, mesh->points + 2 * i, 16) == 0;
            column[i] = same ? values[width * old + k] : out[width * i + k];
        }
        if (k == d->column_count) {
            c->heights = column;
        } else {
            c->columns[k].name = d->columns[k].name;
            c->columns[k].values = column;
            c->column_count++;
        }
    }
    free(values);
    free(out);
    return status;
}

/* ---- markers ---- */

/* Markers of edges and points, as Triangle has them: a point's own; else that of the first segment through it that
   has one; else 1 on the boundary, and 0 inside.  Where nothing has a marker, edges of segments have 1. */
static int carry_markers(const plan *d, const pbw_plane *mesh, const pbw_index *origin, carried *c)
{
    const size_t n = mesh->point_count;
    pbw_index *from = (pbw_index *)malloc((n + 1) * sizeof *from);   /* the segment that a point's marker is of */
    size_t i, k, m;
    c->edge_markers = (int *)calloc(mesh->edge_count + 1, sizeof *c->edge_markers);
    c->point_markers = (int *)calloc(n + 1, sizeof *c->point_markers);
    if (from == NULL || c->edge_markers == NULL || c->point_markers == NULL) {
        free(from);
        return 0;
    }
    memset(from, 255, n * sizeof *from);
    for (i = 0; i < 3 * mesh->triangle_count; i++) {
        if (mesh->neighbors[i] == PBW_NONE || !c->has_markers) {
            c->edge_markers[mesh->constraints[i] == PBW_NONE ? mesh->edge_count : mesh->constraints[i]] = 1;
        }
    }
    for (i = 0; i < mesh->edge_count; i++) {
        for (m = mesh->edge_first[i]; m < mesh->edge_first[i + 1]
             && (d->sources == NULL || d->sources[mesh->edge_segments[m]].marker == 0); m++) {
        }
        if (m < mesh->edge_first[i + 1]) {
            c->edge_markers[i] = d->sources[mesh->edge_segments[m]].marker;
        }
        for (k = 0; k < 2; k++) {
            const pbw_index p = mesh->edges[2 * i + k];
            const pbw_index s = m < mesh->edge_first[i + 1] ? mesh->edge_segments[m] : PBW_NONE;
            if (c->edge_markers[i] != 0 && (c->point_markers[p] == 0 || s < from[p])) {
                c->point_markers[p] = c->edge_markers[i];
                from[p] = s;
            }
        }
    }
    for (i = 0; i < n; i++) {
        if (d->point_markers != NULL && origin[i] != PBW_NONE && d->point_markers[origin[i]] != 0) {
            c->point_markers[i] = d->point_markers[origin[i]];
        }
    }
    free(from);
    return 1;
}

/* ---- groups ---- */

typedef struct item { long long tag; pbw_index place; } item;

static int compare_items(const void *one, const void *other)
{
    const item *a = (const item *)one, *b = (const item *)other;
    return (a->tag > b->tag) - (a->tag < b->tag);
}

static int compare_ints(const void *one, const void *other)
{
    const int a = *(const int *)one, b = *(const int *)other;
    return (a > b) - (a < b);
}

/* Adds a group for each marker but 0, and finds the group of each item. */
static int group_markers(carried *c, int dim, const int *markers, size_t count, pbw_index *of)
{
    int *sorted = (int *)malloc((count + 1) * sizeof *sorted);
    size_t i, n = 0;
    void *more;
    if (sorted == NULL) {
        return 0;
    }
    memcpy(sorted, markers, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_ints);
    for (i = 0; i < count; i++) {
        if (sorted[i] != 0 && (n == 0 || sorted[n - 1] != sorted[i])) {
            sorted[n++] = sorted[i];
        }
    }
    more = realloc(c->groups, (c->group_count + n + 1) * sizeof *c->groups);
    if (more == NULL) {
        free(sorted);
        return 0;
    }
    c->groups = (pbwio_group *)more;
    for (i = 0; i < count; i++) {
        const int *at = (const int *)bsearch(markers + i, sorted, n, sizeof *sorted, compare_ints);
        of[i] = at != NULL ? (pbw_index)(c->group_count + (size_t)(at - sorted)) : PBW_NONE;
    }
    for (i = 0; i < n; i++) {
        c->groups[c->group_count].dim = dim;
        c->groups[c->group_count].tag = sorted[i];
        c->groups[c->group_count++].name = NULL;
    }
    free(sorted);
    return 1;
}

/* The groups of regions: those of the domain's, else one a region. */
static int group_regions(const plan *d, const pbw_plane *mesh, carried *c)
{
    const size_t own = d->region_count > 0 || d->has_groups ? d->group_count : 0;
    const size_t more = d->region_count > 0 || own > 0 ? 0 : mesh->region_count;
    size_t i;
    c->groups = (pbwio_group *)calloc(own + more + 1, sizeof *c->groups);
    c->names = (char (*)[32])malloc((more + 1) * sizeof *c->names);
    c->regions = (pbw_index *)malloc((mesh->triangle_count + 1) * sizeof *c->regions);
    if (c->groups == NULL || c->names == NULL || c->regions == NULL) {
        return 0;
    }
    if (own > 0) {
        memcpy(c->groups, d->groups, own * sizeof *c->groups);
    }
    for (i = 0; i < more; i++) {
        snprintf(c->names[i], sizeof c->names[i], "region_%zu", i);
        c->groups[i].dim = 2;
        c->groups[i].tag = (long long)i + 1;
        c->groups[i].name = c->names[i];
    }
    c->group_count = own + more;
    for (i = 0; i < mesh->triangle_count; i++) {
        const pbw_index seed = mesh->region_seeds[mesh->regions[i]];
        c->regions[i] = more > 0 ? mesh->regions[i] : seed == PBW_NONE || d->has_groups ? seed
                      : d->region_groups[seed];
    }
    return 1;
}

/* Edges are in the groups that the mesh lists. */
static int group_edges(const pbw_plane *mesh, carried *c)
{
    size_t i;
    for (i = 0; i < mesh->edge_count; i++) {
        const size_t first = mesh->edge_first[i];
        c->edge_groups[i] = first < mesh->edge_first[i + 1] ? mesh->edge_segments[first] : PBW_NONE;
    }
    return mesh->edge_first[mesh->edge_count] > 0;
}

/* For each group without a name the one of points with its tag and without a name, or PBW_NONE; after the last, that
   of the tag 1.  The caller frees it; NULL: no memory. */
static pbw_index *find_markers(const plan *d)
{
    item *items = (item *)malloc((d->group_count + 1) * sizeof *items);
    pbw_index *found = (pbw_index *)malloc((d->group_count + 1) * sizeof *found);
    size_t i, count = 0;
    for (i = 0; items != NULL && i < d->group_count; i++) {
        if (d->groups[i].dim == 0 && d->groups[i].name == NULL) {
            items[count].tag = d->groups[i].tag;
            items[count++].place = (pbw_index)i;
        }
    }
    if (items != NULL && found != NULL) {
        qsort(items, count, sizeof *items, compare_items);
        for (i = 0; i <= d->group_count; i++) {
            item wanted, *at;
            wanted.tag = i < d->group_count ? d->groups[i].tag : 1;
            at = (item *)bsearch(&wanted, items, count, sizeof *items, compare_items);
            found[i] = at != NULL && (i == d->group_count || d->groups[i].name == NULL) ? at->place : PBW_NONE;
        }
    } else {
        free(found);
        found = NULL;
    }
    free(items);
    return found;
}

/* Points stay in their groups.  Groups without a name are markers: points in none that are on edges of a group get
   its tag if it is a marker of points; where no edge is in a group, those on the boundary get 1 likewise. */
static int group_points(const plan *d, const pbw_plane *mesh, const pbw_index *origin, carried *c, int edges)
{
    pbw_index *markers = find_markers(d);
    size_t i, k;
    for (i = 0; i < mesh->point_count; i++) {
        c->point_groups[i] = origin[i] == PBW_NONE ? PBW_NONE : d->point_groups[origin[i]];
    }
    for (i = 0; markers != NULL && i < 3 * mesh->triangle_count; i++) {
        const pbw_index edge = mesh->constraints[i];
        const pbw_index group = edges && edge != PBW_NONE ? c->edge_groups[edge] : PBW_NONE;
        const pbw_index marker = group != PBW_NONE ? markers[group]
                               : !edges && mesh->neighbors[i] == PBW_NONE ? markers[d->group_count] : PBW_NONE;
        for (k = 1; k < 3 && marker != PBW_NONE; k++) {
            pbw_index *own = c->point_groups + mesh->triangles[i / 3 * 3 + (i + k) % 3];
            *own = *own == PBW_NONE ? marker : *own;
        }
    }
    free(markers);
    return markers != NULL;
}

static int carry_groups(const plan *d, const pbw_plane *mesh, const pbw_index *origin, carried *c)
{
    int edges = c->has_markers, points = c->has_markers;
    size_t i;
    c->edge_groups = (pbw_index *)malloc((mesh->edge_count + 1) * sizeof *c->edge_groups);
    c->point_groups = (pbw_index *)malloc((mesh->point_count + 1) * sizeof *c->point_groups);
    c->patches = (pbw_index *)malloc((3 * mesh->triangle_count + 1) * sizeof *c->patches);
    if (c->edge_groups == NULL || c->point_groups == NULL || c->patches == NULL || !group_regions(d, mesh, c)
        || (c->has_markers && !(group_markers(c, 1, c->edge_markers, mesh->edge_count, c->edge_groups)
                                && group_markers(c, 0, c->point_markers, mesh->point_count, c->point_groups)))) {
        return 0;
    }
    if (d->has_groups) {
        edges = group_edges(mesh, c);
        points = d->point_groups != NULL;
    }
    if (d->has_groups && points && !group_points(d, mesh, origin, c, edges)) {
        return 0;
    }
    for (i = 0; i < 3 * mesh->triangle_count && edges; i++) {
        c->patches[i] = mesh->constraints[i] == PBW_NONE ? PBW_NONE : c->edge_groups[mesh->constraints[i]];
    }
    if (!edges) {
        free(c->edge_groups);
        free(c->patches);
        c->edge_groups = c->patches = NULL;
    }
    if (!points) {
        free(c->point_groups);
        c->point_groups = NULL;
    }
    return 1;
}

/* ---- all of it ---- */

void warn_of_losses(const job *j, const plan *d, const pbw_plane *plane)
{
    char line[40] = "";
    unsigned char *seen = (unsigned char *)calloc(d->segment_count + d->region_count + 1, 1);
    size_t i, segments = 0, regions = 0, first = 0;
    for (i = 0; seen != NULL && i < plane->edge_first[plane->edge_count]; i++) {
        seen[plane->edge_segments[i]] = 1;
    }
    for (i = 0; seen != NULL && i < plane->region_count; i++) {
        if (plane->region_seeds[i] < d->region_count) {
            seen[d->segment_count + plane->region_seeds[i]] = 1;
        }
    }
    for (i = 0; seen != NULL && i < d->segment_count; i++) {
        const double *a = d->points + 2 * (size_t)d->segments[2 * i];
        const double *b = d->points + 2 * (size_t)d->segments[2 * i + 1];
        if (!seen[i] && (a[0] < b[0] || a[0] > b[0] || a[1] < b[1] || a[1] > b[1])) {
            first = segments++ == 0 ? i : first;
        }
    }
    for (i = 0; seen != NULL && i < d->region_count; i++) {
        regions += !seen[d->segment_count + i];
    }
    free(seen);
    if (segments > 0) {
        const double *a = d->points + 2 * (size_t)d->segments[2 * first];
        if (d->sources != NULL) {
            snprintf(line, sizeof line, " in line %zu,", d->sources[first].line);
        }
        warn(j, "%s: %zu of %zu segments are outside of the domain and left out, the first%s from (%.9g, %.9g)",
             j->input, segments, d->segment_count, line, a[0], a[1]);
    }
    if (regions > 0) {
        warn(j, "%s: %zu of %zu regions mark nothing: they are outside of the domain, or a later one marks the same",
             j->input, regions, d->region_count);
    }
}

pbw_status carry(const job *j, const plan *d, const pbw_plane *own, const pbw_plane *mesh, const pbw_index *origin,
                 carried *c)
{
    pbw_status status = PBW_OK;
    size_t i;
    for (i = 0; d->sources != NULL && i < d->segment_count; i++) {
        c->has_markers |= d->sources[i].marker != 0;
    }
    for (i = 0; d->point_markers != NULL && i < d->point_count; i++) {
        c->has_markers |= d->point_markers[i] != 0;
    }
    if (own != NULL) {
        status = carry_values(j, d, own, mesh, origin, c);
    }
    return status != PBW_OK ? status
         : carry_markers(d, mesh, origin, c) && carry_groups(d, mesh, origin, c) ? PBW_OK : PBW_ERROR_MEMORY;
}

void show_carried(pbwio_output *output, const carried *c, int base)
{
    output->regions = c->regions;
    output->patches = c->patches;
    output->groups = c->groups;
    output->group_count = c->group_count;
    output->point_groups = c->point_groups;
    output->columns = c->columns;
    output->column_count = c->column_count;
    output->heights = c->heights;
    output->base = base;
}

void carried_free(carried *c)
{
    size_t k;
    for (k = 0; k < c->column_count; k++) {
        free(c->columns[k].values);
    }
    free(c->columns);
    free(c->heights);
    free(c->edge_markers);
    free(c->point_markers);
    free(c->groups);
    free(c->names);
    free(c->regions);
    free(c->edge_groups);
    free(c->patches);
    free(c->point_groups);
    memset(c, 0, sizeof *c);
}
