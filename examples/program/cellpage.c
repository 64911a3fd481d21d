/* cellpage.c: cells as a page.
   In: cells with shapes.  Out: the page of a mesh in which a cell is the simplices between its centroid and its
   facets; in space a facet is triangles around its middle, which both cells beside it share.  Cells in a polygon may
   have notches and holes: they are shown flat in space, each as one facet of the triangles of its own corners.  Of
   those triangles only the sides that are edges of the cell are drawn. */
#include "program.h"

typedef struct pieces {
    const pbw_cells *cells;
    double *points;                                  /* centroids, corners, in space middles of facets */
    pbw_index *simplices;
    double *volume;                                  /* of the cell, per simplex; its facets, its number */
    uint32_t *facets, *cell;
    size_t count, point_count, room, point_room;
    int dim;                                         /* of the page */
} pieces;

static int resize(void *array, size_t bytes)
{
    void *old, *made;
    memcpy(&old, array, sizeof old);
    made = realloc(old, bytes);
    if (made != NULL) {
        memcpy(array, &made, sizeof made);
    }
    return made != NULL;
}

/* Room for more points and simplices.  Returns 0 if there is no memory. */
static int make_room(pieces *p, size_t points, size_t simplices)
{
    const size_t dim = (size_t)p->dim;
    if (p->point_count + points > p->point_room) {
        const size_t room = p->point_room + p->point_room / 2 + points;
        if (!resize(&p->points, room * dim * sizeof(double))) {
            return 0;
        }
        memset(p->points + p->point_room * dim, 0, (room - p->point_room) * dim * sizeof(double));
        p->point_room = room;
    }
    if (p->count + simplices > p->room) {
        const size_t room = p->room + p->room / 2 + simplices;
        if (!resize(&p->simplices, room * (dim + 1) * sizeof(pbw_index)) || !resize(&p->volume, room * sizeof(double))
            || !resize(&p->facets, room * sizeof(uint32_t)) || !resize(&p->cell, room * sizeof(uint32_t))) {
            return 0;
        }
        p->room = room;
    }
    return 1;
}

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
    const size_t dim = (size_t)p->dim;
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

static pbw_index add_point(pieces *p, double x, double y)
{
    double *at = p->points + 3 * p->point_count;
    at[0] = x;
    at[1] = y;
    at[2] = 0;
    return (pbw_index)p->point_count++;
}

/* Triangle abc of cell i, whose sides across from its corners are the cell's edges or not: a part for each edge. */
static void add_triangle(pieces *p, size_t i, const pbw_index *at, const int *edge)
{
    const int edges = edge[0] + edge[1] + edge[2];
    const double *x = p->points;                     /* there is room */
    int k;
    for (k = 0; k < 3; k++) {
        const pbw_index a = at[k], b = at[(k + 1) % 3], c = at[(k + 2) % 3];
        if (edges == 2 && !edge[k]) {                /* from the middle of the side that is none */
            const pbw_index m = add_point(p, 0.5 * (x[3 * b] + x[3 * c]), 0.5 * (x[3 * b + 1] + x[3 * c + 1]));
            add_simplex(p, i, m, a, b);
            add_simplex(p, i, m, c, a);
        } else if (edges < 2 && (edge[k] || (edges == 0 && k == 0))) {
            add_simplex(p, i, a, b, c);
        }
    }
    if (edges == 3) {
        const pbw_index m = add_point(p, (x[3 * at[0]] + x[3 * at[1]] + x[3 * at[2]]) / 3,
                                      (x[3 * at[0] + 1] + x[3 * at[1] + 1] + x[3 * at[2] + 1]) / 3);
        for (k = 0; k < 3; k++) {
            add_simplex(p, i, m, at[k], at[(k + 1) % 3]);
        }
    }
}

/* The triangles of a cell in a polygon. */
static int add_triangles(pieces *p, size_t i, const pbw_plane *plane)
{
    const size_t base = p->point_count;
    size_t t, k;
    if (!make_room(p, plane->point_count + plane->triangle_count, 3 * plane->triangle_count)) {
        return 0;
    }
    for (t = 0; t < plane->point_count; t++) {
        (void)add_point(p, plane->points[2 * t], plane->points[2 * t + 1]);
    }
    for (t = 0; t < plane->triangle_count; t++) {
        pbw_index corner[3];
        int edge[3];
        for (k = 0; k < 3; k++) {
            corner[k] = (pbw_index)base + plane->triangles[3 * t + k];
            edge[k] = plane->constraints[3 * t + k] != PBW_NONE;
        }
        add_triangle(p, i, corner, edge);
    }
    return 1;
}

/* A cell in a polygon: the triangles of its own corners, and of crossings that their rounding has made.  Returns 0 if
   there is no memory. */
static int add_polygon(pieces *p, size_t i)
{
    const pbw_cells *cells = p->cells;
    const size_t count = cells->first[i + 1] - cells->first[i];
    const pbw_index *loop = cells->loops + cells->loop_first[cells->first[i]];
    pbw_index *segments = (pbw_index *)malloc(2 * count * sizeof *segments);
    double *x = (double *)malloc(4 * count * sizeof *x);
    pbw_plane_input input;
    pbw_plane_options options;
    pbw_plane plane;
    size_t m;
    int good = x != NULL && segments != NULL;
    memset(&input, 0, sizeof input);
    memset(&options, 0, sizeof options);
    memset(&plane, 0, sizeof plane);
    for (m = 0; good && m < 2 * count; m++) {        /* two corners an edge */
        memcpy(x + 2 * m, cells->vertices + 2 * (size_t)loop[m], 2 * sizeof *x);
        segments[m] = (pbw_index)m;
    }
    input.points = x;
    input.point_count = 2 * count;
    input.segments = segments;
    input.segment_count = count;
    options.rule = PBW_PLANE_EVEN_ODD;
    options.flags = PBW_PLANE_SPLIT_CROSSINGS;
    if (good) {
        const pbw_status status = pbw_plane_make(&input, &options, &plane);
        good = status != PBW_ERROR_MEMORY && (status != PBW_OK || add_triangles(p, i, &plane));
    }
    pbw_plane_free(&plane);
    free(segments);
    free(x);
    return good;
}

/* All cells.  Returns how many are shown; -1: there is no memory. */
static long add_cells(pieces *p)
{
    const pbw_cells *cells = p->cells;
    const size_t dim = (size_t)cells->dim, size = (size_t)p->dim;
    const int polygons = dim != size;
    size_t i, f, k, most = polygons ? 0 : cells->loop_first[cells->facet_count] + 1;
    long shown = 0;
    if (!make_room(p, cells->cell_count + (polygons ? 0 : cells->vertex_count + cells->facet_count) + 1, most)) {
        return -1;
    }
    p->point_count = cells->cell_count + (polygons ? 0 : cells->vertex_count + (dim == 3 ? cells->facet_count : 0));
    for (i = 0; i < cells->cell_count; i++) {
        for (k = 0; k < dim; k++) {
            p->points[size * i + k] = cells->centroids[dim * i + k];
        }
        if (polygons && is_shown(cells, i) && !add_polygon(p, i)) {
            return -1;
        }
        for (f = cells->first[i]; !polygons && is_shown(cells, i) && f < cells->first[i + 1]; f++) {
            add_facet(p, i, f);
        }
        shown += is_shown(cells, i);
    }
    if (!polygons) {
        memcpy(p->points + dim * cells->cell_count, cells->vertices, cells->vertex_count * dim * sizeof(double));
    }
    return shown;
}

static pbwio_status write_pieces(job *j, const pieces *p, const char *path, long shown, pbwio_error *error)
{
    pbwview_array arrays[3];
    pbwview_options view;
    pbw_mesh mesh;
    char note[64];
    memset(&mesh, 0, sizeof mesh);
    memset(&view, 0, sizeof view);
    memset(arrays, 0, sizeof arrays);
    mesh.dim = p->dim;
    mesh.points = p->points;
    mesh.point_count = p->point_count;
    mesh.simplices = p->simplices;
    mesh.simplex_count = p->count;
    snprintf(note, sizeof note, "%zu cell%s", COUNT(shown));
    arrays[0].name = p->cells->dim == 3 ? "volume" : "area";
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
    if (p->dim != p->cells->dim) {                   /* from above, whole */
        view.eye[2] = view.up[1] = 1;
        view.cut[0] = view.cut[3] = 1;
    }
    return pbwview_write(path, &mesh, &view, error);
}

pbwio_status write_cell_page(job *j, const char *path, const pbw_cells *cells, int in_polygon, pbwio_error *error)
{
    pbwio_status status = PBWIO_ERROR_MEMORY;
    pieces p;
    long shown;
    memset(&p, 0, sizeof p);
    p.cells = cells;
    p.dim = in_polygon ? 3 : cells->dim;
    shown = add_cells(&p);
    snprintf(error->text, sizeof error->text, "out of memory");
    if (shown >= 0) {
        status = write_pieces(j, &p, path, shown, error);
    }
    free(p.points);
    free(p.simplices);
    free(p.volume);
    free(p.facets);
    free(p.cell);
    return status;
}
