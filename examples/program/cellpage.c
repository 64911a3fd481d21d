/* cellpage.c: cells as a page.
   In: cells with shapes.  Out: the page of a mesh in which a cell is the simplices between its centroid and its
   facets; in space a facet is triangles around its middle, which both cells beside it share. */
#include "program.h"

typedef struct pieces {
    const pbw_cells *cells;
    double *points;                                  /* centroids, corners, in space middles of facets */
    pbw_index *simplices;
    double *volume;                                  /* of the cell, per simplex; its facets, its number */
    uint32_t *facets, *cell;
    size_t count;
} pieces;

static int is_shown(const pbw_cells *cells, size_t i)
{
    return cells->volumes[i] > 0 && cells->volumes[i] <= DBL_MAX && cells->first[i] < cells->first[i + 1];
}

/* The number of the middle of facet f of cell i: of the two that may be one, the facet of the first cell. */
static size_t middle_of(const pbw_cells *cells, size_t i, size_t f)
{
    const size_t j = cells->neighbors[f], count = cells->loop_first[f + 1] - cells->loop_first[f];
    size_t g, m, same;
    for (g = j < i ? cells->first[j] : 0; j < i && g < cells->first[j + 1]; g++) {
        if (cells->neighbors[g] == i && cells->loop_first[g + 1] - cells->loop_first[g] == count) {
            for (same = m = 0; m < count; m++) {     /* one corner in common is enough: they are of one mesh */
                same += cells->loops[cells->loop_first[g] + m] == cells->loops[cells->loop_first[f]];
            }
            if (same > 0) {
                return g;
            }
        }
    }
    return f;
}

static void add_simplex(pieces *p, size_t i, pbw_index a, pbw_index b, pbw_index c)
{
    const size_t dim = (size_t)p->cells->dim;
    pbw_index *corner = p->simplices + (dim + 1) * p->count;
    corner[0] = (pbw_index)i;
    corner[1] = dim == 3 ? a : b;
    corner[2] = dim == 3 ? b : c;
    corner[dim] = c;
    p->volume[p->count] = p->cells->volumes[i];
    p->facets[p->count] = (uint32_t)(p->cells->first[i + 1] - p->cells->first[i]);
    p->cell[p->count++] = (uint32_t)i;
}

/* Facet f of cell i. */
static void add_facet(pieces *p, size_t i, size_t f)
{
    const pbw_cells *cells = p->cells;
    const size_t dim = (size_t)cells->dim, begin = cells->loop_first[f], end = cells->loop_first[f + 1];
    const size_t base = cells->cell_count;
    const size_t middle = base + cells->vertex_count + (dim == 3 ? middle_of(cells, i, f) : 0);
    size_t m, k;
    for (m = begin; dim == 3 && m < end; m++) {
        for (k = 0; k < 3; k++) {
            const double x = cells->vertices[3 * (size_t)cells->loops[m] + k];
            p->points[3 * middle + k] = (m == begin ? 0 : p->points[3 * middle + k]) + x / (double)(end - begin);
        }
    }
    for (m = begin; m < end - (dim == 2); m++) {
        add_simplex(p, i, (pbw_index)middle, (pbw_index)(base + cells->loops[m]),
                    (pbw_index)(base + cells->loops[m + 1 < end ? m + 1 : begin]));
    }
}

static pbwio_status write_pieces(job *j, pieces *p, const char *path, pbwio_error *error)
{
    const pbw_cells *cells = p->cells;
    const size_t dim = (size_t)cells->dim;
    pbwview_array arrays[3];
    pbwview_options view;
    pbw_mesh mesh;
    char note[64];
    size_t i, f, shown = 0;
    for (i = 0; i < cells->cell_count; i++) {
        memcpy(p->points + dim * i, cells->centroids + dim * i, dim * sizeof(double));
        for (f = cells->first[i]; is_shown(cells, i) && f < cells->first[i + 1]; f++) {
            add_facet(p, i, f);
        }
        shown += (size_t)is_shown(cells, i);
    }
    memcpy(p->points + dim * cells->cell_count, cells->vertices, cells->vertex_count * dim * sizeof(double));
    memset(&mesh, 0, sizeof mesh);
    memset(&view, 0, sizeof view);
    memset(arrays, 0, sizeof arrays);
    mesh.dim = cells->dim;
    mesh.points = p->points;
    mesh.point_count = cells->cell_count + cells->vertex_count + (dim == 3 ? cells->facet_count : 0);
    mesh.simplices = p->simplices;
    mesh.simplex_count = p->count;
    snprintf(note, sizeof note, "%zu cell%s", shown, plural(shown));
    arrays[0].name = dim == 3 ? "volume" : "area";
    arrays[0].real = p->volume;
    arrays[1].name = "facets";
    arrays[1].whole = p->facets;
    arrays[2].name = "cell";
    arrays[2].whole = p->cell;
    view.title = j->input != NULL ? j->input : j->generate;
    view.note = note;
    view.arrays = arrays;
    view.array_count = 3;
    view.colour = arrays[0].name;
    view.cells = view.colour_outside = 1;
    return pbwview_write(path, &mesh, &view, error);
}

pbwio_status write_cell_page(job *j, const char *path, const pbw_cells *cells, pbwio_error *error)
{
    const size_t dim = (size_t)cells->dim, most = cells->loop_first[cells->facet_count] + 1;
    const size_t points = cells->cell_count + cells->vertex_count + cells->facet_count + 1;
    pbwio_status status = PBWIO_ERROR_MEMORY;
    pieces p;
    memset(&p, 0, sizeof p);
    p.cells = cells;
    p.points = (double *)calloc(points, dim * sizeof *p.points);
    p.simplices = (pbw_index *)malloc(most * (dim + 1) * sizeof *p.simplices);
    p.volume = (double *)malloc(most * sizeof *p.volume);
    p.facets = (uint32_t *)malloc(most * sizeof *p.facets);
    p.cell = (uint32_t *)malloc(most * sizeof *p.cell);
    snprintf(error->text, sizeof error->text, "out of memory");
    if (p.points != NULL && p.simplices != NULL && p.volume != NULL && p.facets != NULL && p.cell != NULL) {
        status = write_pieces(j, &p, path, error);
    }
    free(p.points);
    free(p.simplices);
    free(p.volume);
    free(p.facets);
    free(p.cell);
    return status;
}
