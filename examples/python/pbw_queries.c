/* pbw_queries.c: what is computed from the arrays of a triangulation that Python owns. */
#include "pbw_python.h"

/* The exact side of q to facet k of simplex t: +1 inside, 0 on it. */
static int side(const arrays *m, int32_t t, int k, const double *q)
{
    const int32_t *corner = m->simplices + (size_t)t * (size_t)(m->dim + 1);
    const double *p[4];
    for (int i = 0; i <= m->dim; i++) {
        p[i] = i == k ? q : m->points + (size_t)corner[i] * (size_t)m->dim;
    }
    return m->dim == 2 ? pbw_orient2(p[0], p[1], p[2]) : pbw_orient3(p[0], p[1], p[2], p[3]);
}

/* For each query the lowest simplex that has it, found by trying all in turn; -1 if it is outside of the hull. */
void pbw_python_try_all(const arrays *mesh, const double *queries, size_t count, int32_t *found)
{
    for (size_t i = 0; i < count; i++) {
        found[i] = -1;
        for (size_t t = 0; found[i] < 0 && t < mesh->simplex_count; t++) {
            int inside = 1;
            for (int k = 0; k <= mesh->dim && inside; k++) {
                inside = side(mesh, (int32_t)t, k, queries + i * (size_t)mesh->dim) >= 0;
            }
            found[i] = inside ? (int32_t)t : -1;
        }
    }
}

/* For each query the lowest simplex that has it, or -1 - t if it is outside of the hull, t being a simplex at it to
   that side.  facets: room for as many. */
int pbw_python_locate(const arrays *a, const double *queries, size_t count, int32_t *found, int32_t *facets)
{
    pbw_mesh mesh;
    pbw_options options;
    watch w;
    pbw_python_view(a, &mesh, &options, &w);
    int status = (int)pbw_locate(&mesh, queries, count, &options, (pbw_index *)found, (pbw_index *)facets);
    for (size_t i = 0; status == (int)PBW_OK && i < count; i++) {
        found[i] = found[i] < 0 ? -1 - (int32_t)((pbw_index)facets[i] / (pbw_index)(a->dim + 1)) : found[i];
    }
    return status;
}

int pbw_python_nearest(const arrays *a, const double *queries, size_t count, size_t k, int32_t *points,
                       double *distances)
{
    pbw_mesh mesh;
    pbw_options options;
    watch w;
    pbw_python_view(a, &mesh, &options, &w);
    return (int)pbw_nearest(&mesh, NULL, queries, count, k, &options, (pbw_index *)points, distances);
}

int pbw_python_coordinates(const arrays *a, const double *queries, size_t count, int scheme, pbw_lists *lists)
{
    pbw_mesh mesh;
    pbw_options options;
    watch w;
    pbw_python_view(a, &mesh, &options, &w);
    return (int)pbw_coordinates(&mesh, queries, count, (pbw_scheme)scheme, &options, lists);
}

/* box: NULL = the whole space.  periodic: bits of axes; then only the points of the arrays count. */
int pbw_python_cells(const arrays *a, const double *box, unsigned periodic, unsigned what, pbw_cells *cells)
{
    pbw_mesh mesh;
    pbw_options options;
    pbw_domain domain = { 0 };
    watch w;
    pbw_python_view(a, &mesh, &options, &w);
    domain.box = box;
    domain.periodic = periodic;
    return (int)(periodic == 0 ? pbw_cells_of(&mesh, &domain, what, &options, cells)
                 : pbw_cells_periodic(a->dim, a->points, a->weights, a->point_count, &domain, what, &options, cells));
}

/* The neighbours of each point p, ascending, in indices[indptr[p]] to indices[indptr[p + 1] - 1].  Point by point,
   its number is appended to the rows of its neighbours, for each is the other's.  The length of indices, which may be
   NULL in a first call for indptr alone; -1 if there is no memory, or if the length is above 2^31 - 1. */
int64_t pbw_python_stars(const arrays *mesh, int32_t *indptr, int32_t *indices)
{
    size_t corners = (size_t)mesh->dim + 1, total = mesh->simplex_count * corners, points = mesh->point_count;
    const int32_t *simplices = mesh->simplices;
    size_t *first = (size_t *)calloc(points + 2, sizeof *first);     /* of a point's simplices in around */
    int32_t *around = (int32_t *)malloc((total + 1) * sizeof *around);
    int32_t *seen = (int32_t *)calloc(points + 1, sizeof *seen);     /* one more than the last point beside it */
    int64_t length = -1;
    if (first != NULL && around != NULL && seen != NULL) {
        for (size_t i = 0; i < total; i++) {
            first[simplices[i] + 2]++;
        }
        for (size_t p = 0; p < points; p++) {
            first[p + 2] += first[p + 1];
        }
        for (size_t i = 0; i < total; i++) {
            around[first[simplices[i] + 1]++] = (int32_t)(i / corners);
        }
        length = 0;
        for (size_t p = 0; p < points; p++) {
            if (indices == NULL) {
                indptr[p] = (int32_t)length;
            }
            for (size_t i = first[p]; i < first[p + 1]; i++) {
                for (size_t k = 0; k < corners; k++) {
                    int32_t q = simplices[(size_t)around[i] * corners + k];
                    if (q != (int32_t)p && seen[q] != (int32_t)p + 1) {
                        seen[q] = (int32_t)p + 1;
                        length++;
                        if (indices != NULL) {
                            indices[indptr[q]++] = (int32_t)p;       /* a row's beginning moves to the next one's */
                        }
                    }
                }
            }
        }
        if (indices == NULL) {
            indptr[points] = (int32_t)length;
        } else {
            memmove(indptr + 1, indptr, points * sizeof *indptr);
            indptr[0] = 0;
        }
    }
    free(first);
    free(around);
    free(seen);
    return length > INT32_MAX ? -1 : length;
}
