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

/* For each query the lowest simplex that has it.  Outside of the hull it is -1 - t: simplex t has a facet of the hull
   that the query sees.  facets: scratch, an entry a query. */
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

/* first, item: of the stars, or NULL to have them made. */
int pbw_python_nearest(const arrays *a, const size_t *first, const int32_t *item, const double *queries, size_t count,
                       size_t k, int32_t *points, double *distances)
{
    pbw_mesh mesh;
    pbw_options options;
    pbw_lists stars = { 0 };
    watch w;
    pbw_python_view(a, &mesh, &options, &w);
    stars.count = a->point_count;
    stars.first = first;
    stars.item = (const pbw_index *)item;
    return (int)pbw_nearest(&mesh, first != NULL ? &stars : NULL, queries, count, k, &options, (pbw_index *)points,
                            distances);
}

int pbw_python_coordinates(const arrays *a, const double *queries, size_t count, int scheme, pbw_lists *lists)
{
    pbw_mesh mesh;
    pbw_options options;
    watch w;
    pbw_python_view(a, &mesh, &options, &w);
    return (int)pbw_coordinates(&mesh, queries, count, (pbw_scheme)scheme, &options, lists);
}

/* box and lattice: NULL = the whole space.  periodic: bits of axes.  In a box or a lattice only the points of the
   arrays count. */
int pbw_python_cells(const arrays *a, const double *box, const double *lattice, unsigned periodic, unsigned what,
                     pbw_cells *cells)
{
    pbw_mesh mesh, own = { 0 };
    pbw_options options;
    pbw_domain domain = { 0 };
    watch w;
    pbw_python_view(a, &mesh, &options, &w);
    domain.box = box;
    domain.lattice = lattice;
    domain.periodic = periodic;
    if (periodic != 0 || lattice != NULL) {
        return (int)pbw_cells_periodic(a->dim, a->points, a->weights, a->point_count, &domain, what, &options, cells);
    }
    if (box == NULL) {
        return (int)pbw_cells_of(&mesh, &domain, what, &options, cells);
    }
    pbw_status status = pbw_triangulate(a->dim, a->points, a->weights, a->point_count, &options, &own);
    if (status == PBW_OK || status == PBW_DEGENERATE) {
        status = pbw_cells_of(&own, &domain, what, &options, cells);
    }
    pbw_free(&own);
    return (int)status;
}

/* Whether the arrays are the triangulation of their points. */
int pbw_python_check(const arrays *a, int *valid)
{
    pbw_mesh mesh;
    pbw_options options;
    pbw_report report;
    watch w;
    pbw_python_view(a, &mesh, &options, &w);
    for (size_t i = 0; i < a->point_count; i++) {
        mesh.duplicate_count += a->canonical[i] != (int32_t)i;
        mesh.hidden_count += a->canonical[i] == (int32_t)i && a->incident[i] < 0;
    }
    const int status = (int)pbw_check(&mesh, &options, &report);
    *valid = status == (int)PBW_OK && report.valid;
    return status;
}

int pbw_python_stars(const arrays *a, pbw_lists *stars)
{
    pbw_mesh mesh;
    pbw_options options;
    watch w;
    pbw_python_view(a, &mesh, &options, &w);
    return (int)pbw_stars(&mesh, &options, stars);
}
