/* groups.c: groups of elements of a file, on a mesh of its simplices.
   In: a cloud, with groups of simplices, facets, edges and points.  Out: patches, one a corner of a simplex.  */
#include "program.h"

typedef struct key { pbw_index v[3], element; } key;

static int by_corners(const void *a, const void *b)
{
    const key *x = (const key *)a, *y = (const key *)b;
    int k;
    for (k = 0; k < 2 && x->v[k] == y->v[k]; k++) {
    }
    return x->v[k] < y->v[k] ? -1 : x->v[k] > y->v[k];
}

static void set_key(key *k, pbw_index a, pbw_index b, pbw_index c)      /* c: PBW_NONE of an edge */
{
    const pbw_index low = a < b ? a : b, high = a < b ? b : a;
    k->v[0] = low < c ? low : c;
    k->v[1] = low < c ? (high < c ? high : c) : low;
    k->v[2] = high < c ? c : high;
}

/* Finds the facets of simplices that are elements: fills `patches`, and reports how many elements are no facet.
   Returns 0 if memory is short. */
static int match_facets(const job *j, const pbw_index *simplices, size_t simplex_count, pbw_index *patches)
{
    const pbwio_cloud *c = &j->cloud;
    const size_t n = (size_t)c->dim + 1, count = n == 4 ? c->triangle_count : c->segment_count;
    const pbw_index *elements = n == 4 ? c->triangles : c->segments;
    const pbw_index *groups = n == 4 ? c->triangle_groups : c->segment_groups;
    key *keys = (key *)malloc((count + 1) * sizeof *keys), wanted;
    unsigned char *found = (unsigned char *)calloc(count + 1, 1);
    size_t i, from, to, lost = 0;
    if (keys == NULL || found == NULL) {
        free(keys);
        free(found);
        return 0;
    }
    for (i = 0; i < count; i++) {
        const pbw_index *e = elements + (n - 1) * i;
        set_key(keys + i, e[0], e[1], n == 4 ? e[2] : PBW_NONE);
        keys[i].element = (pbw_index)i;
    }
    qsort(keys, count, sizeof *keys, by_corners);
    for (i = 0; i < n * simplex_count; i++) {
        const pbw_index *s = simplices + i / n * n;
        const size_t k = i % n;
        set_key(&wanted, s[(k + 1) % n], s[(k + 2) % n], n == 4 ? s[(k + 3) % n] : PBW_NONE);
        for (from = 0, to = count; from < to;) {
            const size_t middle = from + (to - from) / 2;
            if (by_corners(keys + middle, &wanted) < 0) {
                from = middle + 1;
            } else {
                to = middle;
            }
        }
        patches[i] = PBW_NONE;
        if (from < count && by_corners(keys + from, &wanted) == 0) {
            patches[i] = groups[keys[from].element];
            found[from] = 1;
        }
    }
    for (i = 0; i < count; i++) {
        lost += !found[i] && groups[keys[i].element] != PBW_NONE
             && (i == 0 || by_corners(keys + i - 1, keys + i) != 0);
    }
    if (lost > 0) {
        warn(j, "%s: %zu %s of groups %s between %s or at their boundary, and %s left out", j->input, lost,
             n == 4 ? (lost == 1 ? "triangle" : "triangles") : lost == 1 ? "segment" : "segments",
             lost == 1 ? "is not" : "are not", n == 4 ? "tetrahedra" : "triangles", lost == 1 ? "is" : "are");
    }
    free(keys);
    free(found);
    return 1;
}

/* Where elements of a dimension are in groups, those of the others are in none. */
static int complete(pbw_index **groups, size_t count)
{
    if (*groups == NULL && count > 0) {
        *groups = (pbw_index *)malloc(count * sizeof **groups);
        if (*groups != NULL) {
            memset(*groups, 0xff, count * sizeof **groups);      /* PBW_NONE */
        }
    }
    return *groups != NULL || count == 0;
}

int complete_groups(job *j)
{
    pbwio_cloud *c = &j->cloud;
    return c->group_count == 0 || (complete(&c->tetrahedron_groups, c->tetrahedron_count)
                                   && complete(&c->triangle_groups, c->triangle_count)
                                   && complete(&c->segment_groups, c->segment_count))
         ? 0 : fail(j, "out of memory");
}

int complete_faces(job *j)
{
    if (j->cloud.dim != 3 || j->cloud.triangle_count == 0) {
        return fail(j, "%s: it has no faces%s", j->input,
                    j->cloud.dim == 3 ? "; pbw solid --wrap encloses its points" : "");
    }
    if (j->cloud.tetrahedron_count > 0) {
        warn(j, "%s: its %zu tetrahedr%s and their regions are not kept; pbw improve keeps them", j->input,
             j->cloud.tetrahedron_count, j->cloud.tetrahedron_count == 1 ? "on" : "a");
    }
    return complete_groups(j);
}

int find_patches(job *j, const pbw_index *simplices, size_t count)
{
    const size_t n = (size_t)j->cloud.dim + 1;
    int done;
    free(j->patches);
    j->patches = NULL;
    if (j->cloud.group_count == 0) {
        return 0;
    }
    j->patches = (pbw_index *)malloc((n * count + 1) * sizeof *j->patches);
    done = j->patches != NULL;
    if (done && (n == 4 ? j->cloud.triangle_groups : j->cloud.segment_groups) != NULL) {
        done = match_facets(j, simplices, count, j->patches);
    } else if (done) {
        memset(j->patches, 0xff, n * count * sizeof *j->patches);    /* PBW_NONE: the file has no groups of facets */
    }
    return done ? 0 : fail(j, "out of memory");
}

int keep_groups(job *j)
{
    const pbwio_cloud *c = &j->cloud;
    pbwio_output *o = &j->write;
    int failed = complete_groups(j);
    failed = failed ? failed : find_patches(j, j->mesh.simplices, j->mesh.simplex_count);
    if (failed || c->group_count == 0) {
        return failed;
    }
    o->groups = c->groups;
    o->group_count = c->group_count;
    o->regions = c->dim == 3 ? c->tetrahedron_groups : c->triangle_groups;
    o->patches = j->patches;
    o->edges = c->dim == 3 ? c->segments : NULL;
    o->edge_count = c->dim == 3 ? c->segment_count : 0;
    o->edge_groups = c->segment_groups;
    o->point_groups = c->point_groups;
    return 0;
}

void drop_groups(job *j)
{
    pbwio_output *o = &j->write;
    o->groups = NULL;
    o->regions = o->patches = o->edges = o->edge_groups = o->point_groups = NULL;
    o->group_count = o->edge_count = 0;
}
