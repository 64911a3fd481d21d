/* diagram.c: cells as .obj, .vtu, .svg and, by features.c, .geojson.
   In: cells with shapes.  Out: a file of those that are bounded and not empty, with the corners that they have. */
#include "program.h"

typedef struct diagram {
    const pbw_cells *cells;
    const char *ending;
    pbw_index *number;                               /* of each vertex in the file; PBW_NONE: it is not there */
    size_t *seen;                                    /* per vertex: one more than the last cell that has it */
    void *room;                                      /* for features */
    size_t count;                                    /* how many corners are in the file */
    double low[3], high[3];                          /* their bounds */
} diagram;

int is_drawn(const pbw_cells *cells, size_t i)
{
    return cells->volumes[i] > 0 && cells->volumes[i] <= DBL_MAX && cells->first[i] < cells->first[i + 1];
}

static void number_corners(diagram *d)
{
    const pbw_cells *cells = d->cells;
    const size_t dim = (size_t)cells->dim;
    size_t i, m, k;
    for (i = 0; i < cells->vertex_count; i++) {
        d->number[i] = PBW_NONE;
    }
    for (i = 0; i < cells->cell_count; i++) {
        const size_t end = is_drawn(cells, i) ? cells->loop_first[cells->first[i + 1]] : 0;
        for (m = cells->loop_first[cells->first[i]]; m < end; m++) {
            d->number[cells->loops[m]] = 0;
        }
    }
    for (i = 0; i < cells->vertex_count; i++) {
        const double *x = cells->vertices + dim * i;
        if (d->number[i] == PBW_NONE) {
            continue;
        }
        for (k = 0; k < dim; k++) {
            d->low[k] = d->count == 0 || x[k] < d->low[k] ? x[k] : d->low[k];
            d->high[k] = d->count == 0 || x[k] > d->high[k] ? x[k] : d->high[k];
        }
        d->number[i] = (pbw_index)d->count++;
    }
}

static void emit_vertices(const diagram *d, FILE *file, const char *before)
{
    const pbw_cells *cells = d->cells;
    const size_t dim = (size_t)cells->dim;
    size_t i;
    for (i = 0; i < cells->vertex_count; i++) {
        const double *x = cells->vertices + dim * i;
        if (d->number[i] != PBW_NONE) {
            fprintf(file, "%s%.17g %.17g %.17g\n", before, x[0], x[1], dim == 3 ? x[2] : 0.0);
        }
    }
}

size_t loop_end(const pbw_cells *cells, size_t i, size_t f)
{
    const pbw_index begin = cells->loops[cells->loop_first[f]];
    size_t end = f;
    while (cells->dim == 2 && end + 1 < cells->first[i + 1] && cells->loops[cells->loop_first[end] + 1] != begin) {
        end++;
    }
    return end + 1;
}

/* The corners of facet f, or in the plane of the loop that begins with it, each after a blank.  Returns its end. */
static size_t emit_loop(const diagram *d, FILE *file, size_t i, size_t f, pbw_index base)
{
    const pbw_cells *cells = d->cells;
    const size_t end = loop_end(cells, i, f);
    size_t m;
    for (m = f; m < end && cells->dim == 2; m++) {   /* the first corner of each */
        fprintf(file, " %lu", (unsigned long)(d->number[cells->loops[cells->loop_first[m]]] + base));
    }
    for (m = cells->loop_first[f]; cells->dim == 3 && m < cells->loop_first[end]; m++) {
        fprintf(file, " %lu", (unsigned long)(d->number[cells->loops[m]] + base));
    }
    return end;
}

/* Twice the area of the loop in the plane from facet f: below 0 for holes. */
static double loop_area(const pbw_cells *cells, size_t i, size_t f)
{
    const double *o = cells->vertices + 2 * (size_t)cells->loops[cells->loop_first[f]];
    const size_t end = loop_end(cells, i, f);
    double sum = 0;
    for (; f < end; f++) {
        const double *a = cells->vertices + 2 * (size_t)cells->loops[cells->loop_first[f]];
        const double *b = cells->vertices + 2 * (size_t)cells->loops[cells->loop_first[f] + 1];
        sum += (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    }
    return sum;
}

/* The first cell that has a hole, else cell_count. */
static size_t first_hole(const pbw_cells *cells)
{
    size_t i, f;
    for (i = 0; i < cells->cell_count && cells->dim == 2; i++) {
        for (f = cells->first[i]; is_drawn(cells, i) && f < cells->first[i + 1]; f = loop_end(cells, i, f)) {
            if (loop_area(cells, i, f) < 0) {
                return i;
            }
        }
    }
    return cells->cell_count;
}

static void emit_obj(const diagram *d, FILE *file)
{
    const pbw_cells *cells = d->cells;
    size_t i, f;
    emit_vertices(d, file, "v ");
    for (i = 0; i < cells->cell_count; i++) {
        if (!is_drawn(cells, i)) {
            continue;
        }
        fprintf(file, "o cell_%zu\n", i);
        for (f = cells->first[i]; f < cells->first[i + 1]; ) {
            fputc('f', file);
            f = emit_loop(d, file, i, f, 1);
            fputc('\n', file);
        }
    }
}

/* ---- vtu ---- */

/* The corners of a cell, each once; returns how many.  file NULL: counts only. */
static size_t emit_corners(const diagram *d, FILE *file, size_t i)
{
    const pbw_cells *cells = d->cells;
    size_t m, count = 0;
    for (m = cells->loop_first[cells->first[i]]; m < cells->loop_first[cells->first[i + 1]]; m++) {
        if (d->seen[cells->loops[m]] != i + 1) {
            d->seen[cells->loops[m]] = i + 1;
            count++;
            if (file != NULL) {
                fprintf(file, " %lu", (unsigned long)d->number[cells->loops[m]]);
            }
        }
    }
    return count;
}

static void begin_array(FILE *file, const char *type, const char *name)
{
    fprintf(file, "<DataArray type=\"%s\" Name=\"%s\" format=\"ascii\">\n", type, name);
}

static void end_array(FILE *file)
{
    fputs("</DataArray>\n", file);
}

/* How many elements a cell is: in the plane one for each part. */
static size_t elements_of(const pbw_cells *cells, size_t i)
{
    size_t count = 0, f;
    if (!is_drawn(cells, i) || cells->dim == 3) {
        return (size_t)is_drawn(cells, i);
    }
    for (f = cells->first[i]; f < cells->first[i + 1]; f = loop_end(cells, i, f)) {
        count++;
    }
    return count;
}

/* What is said of each element: of its cell. */
static void emit_data(const diagram *d, FILE *file)
{
    const pbw_cells *cells = d->cells;
    size_t i, k;
    fputs("<CellData Scalars=\"volume\">\n", file);
    begin_array(file, "Int64", "id");
    for (i = 0; i < cells->cell_count; i++) {
        for (k = elements_of(cells, i); k > 0; k--) {
            fprintf(file, "%zu\n", i);
        }
    }
    end_array(file);
    begin_array(file, "Float64", "volume");
    for (i = 0; i < cells->cell_count; i++) {
        for (k = elements_of(cells, i); k > 0; k--) {
            fprintf(file, "%.17g\n", cells->volumes[i]);
        }
    }
    end_array(file);
    begin_array(file, "Int64", "facets");
    for (i = 0; i < cells->cell_count; i++) {
        for (k = elements_of(cells, i); k > 0; k--) {
            fprintf(file, "%zu\n", cells->first[i + 1] - cells->first[i]);
        }
    }
    end_array(file);
    fputs("</CellData>\n", file);
}

/* The facets of polyhedra, and where those of each end. */
static void emit_faces(const diagram *d, FILE *file)
{
    const pbw_cells *cells = d->cells;
    size_t i, f, offset = 0;
    begin_array(file, "Int64", "faces");
    for (i = 0; i < cells->cell_count; i++) {
        if (!is_drawn(cells, i)) {
            continue;
        }
        fprintf(file, "%zu", cells->first[i + 1] - cells->first[i]);
        for (f = cells->first[i]; f < cells->first[i + 1]; f++) {
            fprintf(file, " %zu", cells->loop_first[f + 1] - cells->loop_first[f]);
            emit_loop(d, file, i, f, 0);
        }
        fputc('\n', file);
    }
    end_array(file);
    begin_array(file, "Int64", "faceoffsets");
    for (i = 0; i < cells->cell_count; i++) {
        if (is_drawn(cells, i)) {
            const size_t first = cells->first[i], end = cells->first[i + 1];
            offset += 1 + (end - first) + (cells->loop_first[end] - cells->loop_first[first]);
            fprintf(file, "%zu\n", offset);
        }
    }
    end_array(file);
}

/* Corners of each cell, where they end, and the type: 42 is a polyhedron, 7 a polygon. */
static void emit_cells(const diagram *d, FILE *file)
{
    const pbw_cells *cells = d->cells;
    size_t i, f, end, offset = 0;
    begin_array(file, "Int64", "connectivity");
    memset(d->seen, 0, cells->vertex_count * sizeof *d->seen);
    for (i = 0; i < cells->cell_count; i++) {
        if (is_drawn(cells, i) && cells->dim == 3) {
            emit_corners(d, file, i);
        }
        for (f = cells->first[i]; is_drawn(cells, i) && cells->dim == 2 && f < cells->first[i + 1]; ) {
            f = emit_loop(d, file, i, f, 0);
        }
    }
    fputc('\n', file);
    end_array(file);
    begin_array(file, "Int64", "offsets");
    memset(d->seen, 0, cells->vertex_count * sizeof *d->seen);
    for (i = 0; i < cells->cell_count; i++) {
        if (is_drawn(cells, i) && cells->dim == 3) {
            offset += emit_corners(d, NULL, i);
            fprintf(file, "%zu\n", offset);
        }
        for (f = cells->first[i]; is_drawn(cells, i) && cells->dim == 2 && f < cells->first[i + 1]; f = end) {
            end = loop_end(cells, i, f);
            offset += end - f;
            fprintf(file, "%zu\n", offset);
        }
    }
    end_array(file);
    begin_array(file, "UInt8", "types");
    for (i = 0; i < cells->cell_count; i++) {
        for (f = elements_of(cells, i); f > 0; f--) {
            fputs(cells->dim == 3 ? "42\n" : "7\n", file);
        }
    }
    end_array(file);
    if (cells->dim == 3) {
        emit_faces(d, file);
    }
}

static void emit_vtu(const diagram *d, FILE *file)
{
    size_t i, drawn = 0;
    for (i = 0; i < d->cells->cell_count; i++) {
        drawn += elements_of(d->cells, i);
    }
    fprintf(file, "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
            "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n"
            "<Piece NumberOfPoints=\"%zu\" NumberOfCells=\"%zu\">\n", d->count, drawn);
    emit_data(d, file);
    fputs("<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n", file);
    emit_vertices(d, file, "");
    fputs("</DataArray>\n</Points>\n<Cells>\n", file);
    emit_cells(d, file);
    fputs("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n", file);
}

/* ---- svg ---- */

/* Paths, light where they are small and dark where they are large, 1000 wide or high. */
static void emit_svg(const diagram *d, FILE *file)
{
    const pbw_cells *cells = d->cells;
    const double width = d->high[0] - d->low[0], height = d->high[1] - d->low[1];
    const double scale = d->count > 0 ? 1000 / (width > height ? width : height) : 1;
    double least = DBL_MAX, most = 0;
    size_t i, f, begin;
    for (i = 0; i < cells->cell_count; i++) {
        if (is_drawn(cells, i)) {
            least = cells->volumes[i] < least ? cells->volumes[i] : least;
            most = cells->volumes[i] > most ? cells->volumes[i] : most;
        }
    }
    fprintf(file, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-2 -2 %.6g %.6g\">\n"
            "<g stroke=\"#234\" stroke-width=\"1\" stroke-linejoin=\"round\">\n", width * scale + 4,
            height * scale + 4);
    for (i = 0; i < cells->cell_count; i++) {
        double share;
        if (!is_drawn(cells, i)) {
            continue;
        }
        share = most > least * 1.000001 ? log(cells->volumes[i] / least) / log(most / least) : 0.5;
        fprintf(file, "<path id=\"cell_%zu\" fill=\"hsl(210,60%%,%.0f%%)\" d=\"", i, 90 - 50 * share);
        for (f = begin = cells->first[i]; f < cells->first[i + 1]; f++) {
            const double *x = cells->vertices + 2 * (size_t)cells->loops[cells->loop_first[f]];
            fprintf(file, "%s%.6g,%.6g", f == begin ? "M " : " ", (x[0] - d->low[0]) * scale,
                    (d->high[1] - x[1]) * scale);
            if (f + 1 == loop_end(cells, i, begin)) {
                fputs("Z", file);
                begin = f + 1;
            }
        }
        fputs("\"/>\n", file);
    }
    fputs("</g>\n</svg>\n", file);
}

static void emit(void *user, FILE *file)
{
    const diagram *d = (const diagram *)user;
    if (strcmp(d->ending, "obj") == 0) {
        emit_obj(d, file);
    } else if (strcmp(d->ending, "vtu") == 0) {
        emit_vtu(d, file);
    } else if (strcmp(d->ending, "geojson") == 0) {
        emit_cell_features(d->cells, file, d->room);
    } else {
        emit_svg(d, file);
    }
}

pbwio_status write_diagram(const char *path, const char *ending, const pbw_cells *cells, pbwio_error *error)
{
    diagram d;
    pbwio_status status = PBWIO_ERROR_MEMORY;
    if (strcmp(ending, "svg") != 0 && strcmp(ending, "geojson") != 0 && first_hole(cells) < cells->cell_count) {
        snprintf(error->text, sizeof error->text, "%s: cell %zu has a hole, which .%s cannot hold: write .svg or "
                 ".geojson", path, first_hole(cells), ending);
        return PBWIO_ERROR_ARGUMENT;
    }
    memset(&d, 0, sizeof d);
    d.cells = cells;
    d.ending = ending;
    d.number = (pbw_index *)malloc((cells->vertex_count + 1) * sizeof *d.number);
    d.seen = (size_t *)malloc((cells->vertex_count + 1) * sizeof *d.seen);
    d.room = strcmp(ending, "geojson") == 0 ? malloc(cell_features_room(cells)) : d.seen;
    snprintf(error->text, sizeof error->text, "out of memory");
    if (d.number != NULL && d.seen != NULL && d.room != NULL) {
        number_corners(&d);
        status = pbwio_save(path, emit, &d, NULL, error);
    }
    free(d.number);
    free(d.room != d.seen ? d.room : NULL);
    free(d.seen);
    return status;
}
