/* filemesh.c: the simplices of a file as a mesh, and their faults.
   In: a cloud with tetrahedra, or with triangles of the plane.  Out: a mesh with neighbors, its simplices turned
   positive.  Holds: the mesh borrows the cloud's arrays; its neighbors are the job's, `links`. */
#include "program.h"

const option file_mesh_options[] = {
    { "--retriangulate", NULL, "of a file with simplices or faces: triangulate its points instead", SWITCH, 0, 0,
      NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

int has_simplices(const job *j)
{
    return j->cloud.dim == 3 ? j->cloud.tetrahedron_count > 0 : j->cloud.triangle_count > 0;
}

typedef struct facet { pbw_index b, c, id; int odd; } facet;        /* b < c: corners beside the least; id: n t + i */

/* ---- neighbours ---- */

static int by_corners(const void *a, const void *b)
{
    const facet *f = (const facet *)a, *g = (const facet *)b;
    return f->b != g->b ? (f->b < g->b ? -1 : 1) : f->c != g->c ? (f->c < g->c ? -1 : 1)
         : f->id < g->id ? -1 : f->id > g->id;
}

/* Puts the corners of facet i of a simplex into the order of their ids, behind those of an edge PBW_NONE.  Returns
   whether that order and the outward one differ by an odd permutation. */
static int sorted_facet(const pbw_index *simplex, size_t n, size_t i, pbw_index corner[3])
{
    int odd = 0, k;
    size_t m;
    corner[2] = PBW_NONE;
    for (m = 0; m + 1 < n; m++) {
        corner[m] = simplex[n == 4 ? PBW_FACET_CORNER(i, m) : (i + 1 + m) % 3];
    }
    for (k = 0; k < 3; k++) {
        const int at = k == 1 ? 1 : 0;
        if (corner[at] > corner[at + 1]) {
            const pbw_index least = corner[at + 1];
            corner[at + 1] = corner[at];
            corner[at] = least;
            odd = !odd;
        }
    }
    return odd;
}

/* Facets by their least corners: start[p] to start[p + 1] are those of point p.  Returns 0 if there is no memory. */
static int list_facets(const pbw_mesh *mesh, size_t **start, facet **facets)
{
    const size_t n = (size_t)mesh->dim + 1, count = n * mesh->simplex_count;
    pbw_index corner[3];
    size_t i, *at;
    *start = at = (size_t *)calloc(mesh->point_count + 2, sizeof *at);
    *facets = (facet *)malloc((count + 1) * sizeof **facets);
    if (at == NULL || *facets == NULL) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        sorted_facet(mesh->simplices + i / n * n, n, i % n, corner);
        at[corner[0] + 2]++;
    }
    for (i = 2; i < mesh->point_count + 2; i++) {
        at[i] += at[i - 1];
    }
    for (i = 0; i < count; i++) {
        const int odd = sorted_facet(mesh->simplices + i / n * n, n, i % n, corner);
        facet *f = *facets + at[corner[0] + 1]++;
        f->b = corner[1];
        f->c = corner[2];
        f->id = (pbw_index)i;
        f->odd = odd;
    }
    for (i = 0; i < mesh->point_count; i++) {
        qsort(*facets + at[i], at[i + 1] - at[i], sizeof **facets, by_corners);
    }
    return 1;
}

static void count_fault(mesh_fault *f, size_t simplex)
{
    f->first = f->count++ == 0 ? simplex : f->first;
}

/* Links the simplices across facets of two; counts the others. */
static int link_simplices(job *j, mesh_faults *faults)
{
    const pbw_mesh *mesh = &j->mesh;
    const size_t n = (size_t)mesh->dim + 1;
    size_t *start, p, i, end;
    facet *facets;
    int done = list_facets(mesh, &start, &facets);
    j->links = done ? (pbw_index *)malloc((n * mesh->simplex_count + 1) * sizeof *j->links) : NULL;
    for (p = 0; j->links != NULL && p < mesh->point_count; p++) {
        for (i = start[p]; i < start[p + 1]; i = end) {
            for (end = i; end < start[p + 1] && facets[end].b == facets[i].b && facets[end].c == facets[i].c; end++) {
                j->links[facets[end].id] = PBW_NONE;
            }
            if (end - i == 2) {
                j->links[facets[i].id] = facets[i + 1].id / (pbw_index)n;
                j->links[facets[i + 1].id] = facets[i].id / (pbw_index)n;
            }
            if (end - i > 2) {
                count_fault(&faults->crowded, facets[i].id / n);
            } else if (end - i == 2 && facets[i].odd == facets[i + 1].odd) {
                count_fault(&faults->folded, facets[i].id / n);
            }
            faults->boundary += end - i == 1;
        }
    }
    free(start);
    free(facets);
    return j->links != NULL;
}

/* Turns negative simplices by swapping their last corners; counts those and flat ones. */
static void turn_simplices(const pbwio_cloud *cloud, pbw_index *simplices, size_t count, mesh_faults *faults)
{
    const size_t n = (size_t)cloud->dim + 1;
    const double *x = cloud->points;
    size_t i;
    for (i = 0; i < count; i++) {
        pbw_index *t = simplices + n * i, last = t[n - 1];
        const int sign = n == 4 ? pbw_orient3(x + 3 * (size_t)t[0], x + 3 * (size_t)t[1], x + 3 * (size_t)t[2],
                                              x + 3 * (size_t)t[3])
                                : pbw_orient2(x + 2 * (size_t)t[0], x + 2 * (size_t)t[1], x + 2 * (size_t)t[2]);
        if (sign == 0) {
            count_fault(&faults->flat, i);
        } else if (sign < 0) {
            count_fault(&faults->turned, i);
            t[n - 1] = t[n - 2];
            t[n - 2] = last;
        }
    }
}

int take_simplices(job *j, mesh_faults *faults)
{
    const int solid = j->cloud.dim == 3;
    double start = now();
    memset(faults, 0, sizeof *faults);
    memset(&j->mesh, 0, sizeof j->mesh);
    j->mesh.dim = j->cloud.dim;
    j->mesh.points = j->cloud.points;
    j->mesh.point_count = j->cloud.count;
    j->mesh.simplices = solid ? j->cloud.tetrahedra : j->cloud.triangles;
    j->mesh.simplex_count = solid ? j->cloud.tetrahedron_count : j->cloud.triangle_count;
    turn_simplices(&j->cloud, solid ? j->cloud.tetrahedra : j->cloud.triangles, j->mesh.simplex_count, faults);
    if (!link_simplices(j, faults)) {
        return fail(j, "out of memory");
    }
    j->mesh.neighbors = j->links;
    report_step(j, "link", now() - start, "%zu %s, %zu facet%s on the boundary", j->mesh.simplex_count,
                simplices(j->mesh.dim, j->mesh.simplex_count), COUNT(faults->boundary));
    return keep_groups(j);
}

/* ---- the check ---- */

static void tell_fault(const job *j, const mesh_fault *f, const char *what)
{
    if (f->count > 0) {
        report_line(j, "%zu %s; the first: %s %zu", f->count, what, simplices(j->mesh.dim, 1), f->first);
    }
}

/* Facets with a simplex on each side, of which one has the other's corner inside of its sphere. */
static size_t count_not_delaunay(const pbw_mesh *mesh)
{
    const size_t n = (size_t)mesh->dim + 1;
    const double *x = mesh->points;
    size_t i, k, found = 0;
    for (i = 0; i < n * mesh->simplex_count; i++) {
        const pbw_index other = mesh->neighbors[i], *t = mesh->simplices + i / n * n;
        const pbw_index *o = mesh->simplices + n * (size_t)other;
        if (other == PBW_NONE || other < i / n) {
            continue;
        }
        for (k = 0; k + 1 < n && mesh->neighbors[n * (size_t)other + k] != i / n; k++) {
        }
        if (n == 4) {
            found += pbw_insphere(x + 3 * (size_t)t[0], x + 3 * (size_t)t[1], x + 3 * (size_t)t[2],
                                  x + 3 * (size_t)t[3], x + 3 * (size_t)o[k]) > 0;
        } else {
            found += pbw_incircle(x + 2 * (size_t)t[0], x + 2 * (size_t)t[1], x + 2 * (size_t)t[2],
                                  x + 2 * (size_t)o[k]) > 0;
        }
    }
    return found;
}

pbw_index *boundary_of(const job *j, size_t *count)
{
    const pbw_mesh *mesh = &j->mesh;
    pbw_index *triangles, *t, swap;
    size_t i;
    for (i = *count = 0; i < 4 * mesh->simplex_count; i++) {
        *count += mesh->neighbors[i] == PBW_NONE;
    }
    triangles = t = (pbw_index *)malloc((3 * *count + 1) * sizeof *triangles);
    for (i = 0; t != NULL && i < 4 * mesh->simplex_count; i++) {
        if (mesh->neighbors[i] == PBW_NONE) {
            if (sorted_facet(mesh->simplices + i / 4 * 4, 4, i % 4, t)) {
                swap = t[1];
                t[1] = t[2];
                t[2] = swap;
            }
            t += 3;
        }
    }
    return triangles;
}

static int boundary_is_closed(job *j)
{
    pbwio_cloud boundary;
    int closed;
    memset(&boundary, 0, sizeof boundary);
    boundary.dim = 3;
    boundary.count = j->cloud.count;
    boundary.points = j->cloud.points;
    boundary.triangles = boundary_of(j, &boundary.triangle_count);
    closed = boundary.triangles != NULL && describe_surface(j, &boundary, 1);
    free(boundary.triangles);
    return closed;
}

int check_simplices(job *j)
{
    mesh_faults faults;
    size_t not_delaunay;
    double start;
    int failed = take_simplices(j, &faults), closed = 1;
    if (failed) {
        return failed;
    }
    start = now();
    tell_fault(j, &faults.turned, "with negative orientation, turned here");
    tell_fault(j, &faults.flat, "without volume");
    tell_fault(j, &faults.crowded, "facets of more than two simplices");
    tell_fault(j, &faults.folded, "facets with both of their simplices on one side");
    not_delaunay = count_not_delaunay(&j->mesh);
    report_step(j, "check", now() - start, "%s", faults.flat.count + faults.crowded.count + faults.folded.count > 0
                ? "no triangulation" : not_delaunay > 0 ? "links are right" : "links are right, Delaunay");
    if (not_delaunay > 0) {
        report_line(j, "%zu facet%s not Delaunay: a sphere around one side has the corner of the other inside",
                    COUNT(not_delaunay));
    }
    describe_mesh_quality(j);
    if (j->mesh.dim == 3 && faults.crowded.count == 0) {
        closed = boundary_is_closed(j);
    }
    return faults.flat.count + faults.crowded.count + faults.folded.count > 0 ? fail(j, "the mesh has faults")
         : closed ? 0 : fail(j, "the boundary of the mesh is no closed surface");
}
