/* carry.c: what the points and segments of a plane domain carry to its mesh: columns and heights, linear in the
   domain's own triangles; markers; regions.
   In: a domain, its own triangulation, its mesh, and where the points of that are from.  Out: columns, heights and
   markers of the mesh; groups. */
#include "domain.h"

/* ---- points that coincide: the first one's values count */

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

/* ---- values */

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

/* Columns, then heights, at the points of the mesh. */
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
            column[i] = origin[i] != PBW_NONE ? values[width * origin[i] + k] : out[width * i + k];
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

/* ---- markers */

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

/* ---- groups */

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
    const size_t own = d->region_count > 0 ? d->group_count : 0, more = d->region_count > 0 ? 0 : mesh->region_count;
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
        c->regions[i] = more > 0 ? mesh->regions[i] : seed == PBW_NONE ? PBW_NONE : d->region_groups[seed];
    }
    return 1;
}

static int carry_groups(const plan *d, const pbw_plane *mesh, carried *c)
{
    pbw_index *of_edges = (pbw_index *)malloc((mesh->edge_count + 1) * sizeof *of_edges);
    size_t i;
    int done = of_edges != NULL && group_regions(d, mesh, c);
    if (done && c->has_markers) {
        c->patches = (pbw_index *)malloc((3 * mesh->triangle_count + 1) * sizeof *c->patches);
        c->point_groups = (pbw_index *)malloc((mesh->point_count + 1) * sizeof *c->point_groups);
        done = c->patches != NULL && c->point_groups != NULL
            && group_markers(c, 1, c->edge_markers, mesh->edge_count, of_edges)
            && group_markers(c, 0, c->point_markers, mesh->point_count, c->point_groups);
        for (i = 0; done && i < 3 * mesh->triangle_count; i++) {
            c->patches[i] = mesh->constraints[i] == PBW_NONE ? PBW_NONE : of_edges[mesh->constraints[i]];
        }
    }
    free(of_edges);
    return done;
}

/* ---- all of it */

pbw_status carry(const job *j, const plan *d, const pbw_plane *own, const pbw_plane *mesh, const pbw_index *origin,
                 carried *c)
{
    pbw_status status = PBW_OK;
    size_t i;
    for (i = 0; i < d->segment_count; i++) {
        c->has_markers |= d->sources[i].marker != 0;
    }
    for (i = 0; d->point_markers != NULL && i < d->point_count; i++) {
        c->has_markers |= d->point_markers[i] != 0;
    }
    if (own != NULL) {
        status = carry_values(j, d, own, mesh, origin, c);
    }
    return status != PBW_OK ? status
         : carry_markers(d, mesh, origin, c) && carry_groups(d, mesh, c) ? PBW_OK : PBW_ERROR_MEMORY;
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
    free(c->patches);
    free(c->point_groups);
    memset(c, 0, sizeof *c);
}
