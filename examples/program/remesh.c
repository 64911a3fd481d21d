/* remesh.c: triangles of the plane that a file has, as a domain: their regions, groups of edges and points.
   In: the job's cloud.  Out: a domain that owns what the cloud had; planes of it. */
#include "domain.h"

/* Whether markers of the cloud's points are numbers as Triangle has them: nothing else is in a group. */
static int are_markers(const pbwio_cloud *c)
{
    size_t i;
    for (i = 0; i < c->group_count && c->groups[i].dim == 0 && c->groups[i].name == NULL
         && c->groups[i].tag >= INT_MIN && c->groups[i].tag <= INT_MAX; i++) {
    }
    return i == c->group_count && c->triangle_count + c->segment_count == 0;
}

int take_cloud(job *j, plan *d)
{
    pbwio_cloud *c = &j->cloud;
    const int markers = are_markers(c);
    size_t i;
    int failed = complete_groups(j);
    d->points = c->points;
    d->point_count = c->count;
    d->sizes = c->weights;
    d->triangles = c->triangles;
    d->triangle_count = c->triangle_count;
    d->segments = c->segments;
    d->segment_count = c->segment_count;
    d->heights = c->heights;
    d->columns = c->columns;
    d->column_count = c->column_count;
    d->base = c->base;
    c->points = c->weights = c->heights = NULL;
    c->triangles = c->segments = NULL;
    c->columns = NULL;
    c->triangle_count = c->segment_count = c->column_count = 0;
    if (markers && c->point_groups != NULL) {
        d->point_markers = (int *)calloc(d->point_count + 1, sizeof *d->point_markers);
        failed = failed || d->point_markers != NULL ? failed : fail(j, "out of memory");
    }
    for (i = 0; d->point_markers != NULL && i < d->point_count; i++) {
        const pbw_index g = c->point_groups[i];
        d->point_markers[i] = g == PBW_NONE ? 0 : (int)c->groups[g].tag;
    }
    if (!markers) {
        d->groups = c->groups;
        d->group_count = c->group_count;
        d->has_groups = d->group_count > 0;
        d->triangle_groups = c->triangle_groups;
        d->segment_groups = c->segment_groups;
        d->point_groups = c->point_groups;
        c->groups = NULL;
        c->group_count = 0;
        c->triangle_groups = c->segment_groups = c->point_groups = NULL;
    }
    return failed;
}

int view_triangles(const plan *d, pbw_plane *view, pbw_index **corners)
{
    size_t i;
    memset(view, 0, sizeof *view);
    *corners = (pbw_index *)malloc((d->triangle_count + 1) * 3 * sizeof **corners);
    if (*corners == NULL) {
        return 0;
    }
    memcpy(*corners, d->triangles, d->triangle_count * 3 * sizeof **corners);
    for (i = 0; i < d->triangle_count; i++) {
        const pbw_index *t = d->triangles + 3 * i;
        if (pbw_orient2(d->points + 2 * (size_t)t[0], d->points + 2 * (size_t)t[1],
                        d->points + 2 * (size_t)t[2]) < 0) {
            (*corners)[3 * i] = t[1];
            (*corners)[3 * i + 1] = t[0];
        }
    }
    view->points = d->points;
    view->point_count = d->point_count;
    view->triangles = *corners;
    view->triangle_count = d->triangle_count;
    return 1;
}

pbw_status make_again(const plan *d, const pbw_plane_options *options, pbw_plane *plane)
{
    pbw_plane_input input;
    memset(&input, 0, sizeof input);
    input.points = d->points;
    input.point_count = d->point_count;
    input.segments = d->segments;
    input.segment_count = d->segment_count;
    return pbw_plane_from_triangles(&input, d->triangles, d->triangle_groups, d->triangle_count, options, plane);
}

int list_groups(const plan *d, pbw_plane *plane, void *own[2])
{
    size_t *first = (size_t *)malloc((plane->edge_count + 1) * sizeof *first);
    pbw_index *groups = (pbw_index *)malloc((plane->edge_count + 1) * sizeof *groups);
    size_t i, m, count = 0;
    own[0] = first;
    own[1] = groups;
    if (first == NULL || groups == NULL) {
        return 0;
    }
    for (i = 0; i < plane->edge_count; i++) {
        first[i] = count;
        for (m = plane->edge_first[i]; m < plane->edge_first[i + 1] && count == first[i] && d->has_groups; m++) {
            groups[count] = d->segment_groups[plane->edge_segments[m]];
            count += groups[count] != PBW_NONE;
        }
    }
    first[plane->edge_count] = count;
    plane->edge_first = first;
    plane->edge_segments = groups;
    return 1;
}

int find_origins(const plan *d, const pbw_plane *plane, const pbw_index *from, pbw_index **origin)
{
    size_t i;
    *origin = (pbw_index *)malloc((plane->point_count + 1) * sizeof **origin);
    for (i = 0; *origin != NULL && i < plane->point_count; i++) {
        const size_t old = from == NULL ? i : i < plane->input_count ? from[i] : d->point_count;
        (*origin)[i] = old < d->point_count ? (pbw_index)old : PBW_NONE;
    }
    return *origin != NULL;
}

unsigned char *points_to_keep(const plan *d, size_t count, const pbw_index *origin)
{
    unsigned char *keep = (unsigned char *)calloc(count + 1, 1);
    size_t i;
    for (i = 0; keep != NULL && d->point_groups != NULL && i < count; i++) {
        const size_t old = origin != NULL ? origin[i] : i;
        const pbw_index g = old < d->point_count ? d->point_groups[old] : PBW_NONE;
        keep[i] = g != PBW_NONE && d->groups[g].name != NULL;
    }
    return keep;
}

pbw_status smooth(const plan *d, pbw_plane *plane, const pbw_index *origin, pbw_plane_way way, int rounds,
                  const pbw_plane_options *options)
{
    unsigned char *keep = points_to_keep(d, plane->point_count, origin);
    const pbw_status status = keep == NULL ? PBW_ERROR_MEMORY : pbw_plane_smooth(plane, way, rounds, keep, options);
    free(keep);
    return status;
}
