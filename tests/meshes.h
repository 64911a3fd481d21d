/* meshes.h: triangulating and comparing meshes in tests.  Include pbw.h before, or
   pbw_check.h for meshes_fault. */
#ifndef MESHES_H
#define MESHES_H

#include "zoo.h"

/* 1 if all arrays and counts are the same, byte for byte. */
static inline int meshes_equal(const pbw_mesh *a, const pbw_mesh *b)
{
    size_t corners = (size_t)a->dim + 1, links = a->simplex_count * corners * sizeof(pbw_index);
    size_t each = a->point_count * sizeof(pbw_index);
    if (a->dim != b->dim || a->point_count != b->point_count || a->simplex_count != b->simplex_count
        || a->duplicate_count != b->duplicate_count || a->hidden_count != b->hidden_count
        || (a->neighbors == NULL) != (b->neighbors == NULL) || (a->weights == NULL) != (b->weights == NULL)) {
        return 0;
    }
    if (a->point_count == 0) {
        return 1;
    }
    return (links == 0 || memcmp(a->simplices, b->simplices, links) == 0)
        && (links == 0 || a->neighbors == NULL || memcmp(a->neighbors, b->neighbors, links) == 0)
        && memcmp(a->incident, b->incident, each) == 0 && memcmp(a->canonical, b->canonical, each) == 0
        && memcmp(a->points, b->points, a->point_count * (corners - 1) * sizeof(double)) == 0
        && (a->weights == NULL || memcmp(a->weights, b->weights, a->point_count * sizeof(double)) == 0);
}

/* 1 if the mesh holds nothing. */
static inline int meshes_is_empty(const pbw_mesh *mesh)
{
    pbw_mesh none;
    memset(&none, 0, sizeof none);
    return memcmp(mesh, &none, sizeof none) == 0;
}

static inline pbw_status meshes_make(const zoo_input *in, const pbw_options *options, pbw_mesh *mesh)
{
    return pbw_triangulate(in->dim, in->points, in->weights, in->count, options, mesh);
}

#ifdef PBW_CHECK_H
static inline const char *meshes_fault(const pbw_mesh *mesh)                 /* NULL, or what pbw_check found */
{
    pbw_report report;
    pbw_status status = pbw_check(mesh, NULL, &report);
    return status != PBW_OK ? pbw_status_string(status) : report.valid ? NULL : report.what;
}
#endif

/* The documented order of the arrays, as far as it shows without knowing the curve: all simplices with one first
   corner stand together, and their other corners come later on the curve, so do not begin an earlier group. */
static inline int meshes_in_order(const pbw_mesh *mesh)
{
    size_t corners = (size_t)mesh->dim + 1, i, k, group = 0;
    size_t *rank = (size_t *)zoo_grow(NULL, (mesh->point_count + 1) * sizeof *rank);
    int fits = 1;
    memset(rank, 0, (mesh->point_count + 1) * sizeof *rank);                 /* 0: begins no group */
    for (i = 0; i < mesh->simplex_count; i++) {
        pbw_index first = mesh->simplices[i * corners];
        if (i == 0 || first != mesh->simplices[(i - 1) * corners]) {
            fits &= rank[first] == 0;
            rank[first] = ++group;
        }
    }
    for (i = 0; i < mesh->simplex_count * corners; i++) {
        pbw_index first = mesh->simplices[i / corners * corners], other = mesh->simplices[i];
        fits &= rank[other] == 0 || rank[other] >= rank[first];
    }
    for (i = 0; i < mesh->point_count; i++) {                                /* incident: the first one */
        k = mesh->incident[i];
        fits &= k == PBW_NONE || k < mesh->simplex_count;
        rank[i] = mesh->simplex_count;
    }
    for (i = mesh->simplex_count * corners; i-- > 0;) {
        rank[mesh->simplices[i]] = i / corners;
    }
    for (i = 0; i < mesh->point_count; i++) {
        fits &= mesh->incident[i] == (rank[i] == mesh->simplex_count ? PBW_NONE : (pbw_index)rank[i]);
    }
    free(rank);
    return fits;
}

#endif
