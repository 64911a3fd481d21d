/* pbw_model.h - v0.1.0 - surfaces and points with normals, from files and to files - MIT-0

   In one source file, define PBW_MODEL_IMPLEMENTATION before the include; in all others, only include.
   Needs the implementation of pbw_io.h in the same source file, before it.

       pbwio_cloud cloud, normals;
       pbwmodel_content content = {0};
       pbwio_read("model.obj", NULL, &cloud, &error);
       pbwmodel_read_normals("model.obj", &cloud, &normals);     // where the file has them
       content.points = cloud.points; ...
       pbwmodel_write("points.ply", &content, 0, &error);

   Writes .obj .ply .stl .off with triangles; .xyz .csv and, with normals or without triangles, .obj .ply: points.
*/
#ifndef PBW_MODEL_H
#define PBW_MODEL_H
#ifndef PBW_IO_H
#include "pbw_io.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pbwmodel_content {      /* what is written; the arrays are the caller's */
    int dim;                           /* of the points: 2 or 3 */
    size_t point_count, triangle_count;
    const double *points, *normals;    /* normals: 3 coordinates for each point, or NULL */
    const pbw_index *triangles;
} pbwmodel_content;

/* Reads the normals that a file has beside its points: `vn` of .obj; properties or columns nx ny nz of .ply, .xyz and
   .csv.  normals: points are the normals, triangles their ids for each triangle of the model (none: as the points'
   ids).  Returns whether there are any; if not, normals is empty. */
extern int pbwmodel_read_normals(const char *path, const pbwio_cloud *model, pbwio_cloud *normals);
/* Writes whole or not at all; flags: PBWIO_TEXT. */
extern pbwio_status pbwmodel_write(const char *path, const pbwmodel_content *content, unsigned flags,
                                   pbwio_error *error);

#ifdef __cplusplus
}
#endif
#endif /* PBW_MODEL_H */

#if defined(PBW_MODEL_IMPLEMENTATION) && !defined(PBWMODEL__IMPLEMENTED)
#define PBWMODEL__IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

static char *pbwmodel__load(const char *path, size_t *size)          /* NULL: cannot */
{
    FILE *file = fopen(path, "rb");
    char *data = NULL, *more;
    size_t capacity = 0, got = 1;
    *size = 0;
    while (file != NULL && got > 0) {
        if (*size == capacity) {
            capacity = 2 * capacity + 65536;
            more = (char *)realloc(data, capacity + 1);
            if (more == NULL) {
                break;
            }
            data = more;
        }
        got = fread(data + *size, 1, capacity - *size, file);
        *size += got;
    }
    if (file != NULL && (got > 0 || ferror(file))) {
        free(data);
        data = NULL;
    }
    if (file != NULL) {
        fclose(file);
    }
    return data;
}

/* Makes of an .obj file one whose points are the normals and whose faces have the normals' ids.  A corner without one
   makes it a bad file. */
static void pbwmodel__turn_to_normals(char *text, size_t size)
{
    size_t i = 0, begin;
    while (i < size) {
        int face = i + 1 < size && text[i] == 'f' && (text[i + 1] == ' ' || text[i + 1] == '\t');
        if (i + 1 < size && text[i] == 'v' && text[i + 1] == 'n') {
            text[i + 1] = ' ';
        } else if (!face && text[i] != '\n') {
            text[i] = '#';
        }
        i += face ? 1 : 0;
        while (i < size && text[i] != '\n') {
            int slashes = 0;
            for (begin = i; face && i < size && strchr(" \t\r\n", text[i]) == NULL; i++) {
                if (text[i] == '/') {                                /* of a/b/c or a//c leave c */
                    memset(text + begin, ' ', i + 1 - begin);
                    slashes++;
                }
            }
            if (i > begin && slashes != 2) {
                text[begin] = 'x';
            }
            i += i < size && text[i] != '\n';
        }
        i++;
    }
}

extern int pbwmodel_read_normals(const char *path, const pbwio_cloud *model, pbwio_cloud *normals)
{
    pbwio_options options;
    pbwio_format format = pbwio_format_of(path);
    pbwio_status status;
    size_t size, i;
    char *text;
    memset(&options, 0, sizeof options);
    memset(normals, 0, sizeof *normals);
    options.dim = 3;
    if (strcmp(path, "-") == 0) {
        return 0;
    }
    if (format == PBWIO_OBJ) {
        text = pbwmodel__load(path, &size);
        if (text == NULL) {
            return 0;
        }
        pbwmodel__turn_to_normals(text, size);
        status = pbwio_read_memory("normals.obj", text, size, &options, normals, NULL);
        free(text);
        if (status == PBWIO_OK && normals->count > 0 && normals->triangle_count == model->triangle_count) {
            return 1;
        }
    } else {
        options.columns = "nx,ny,nz";
        status = pbwio_read(path, &options, normals, NULL);
        if (status == PBWIO_OK && normals->count == model->count && normals->count > 0) {
            for (i = 0; i < 3 * normals->triangle_count; i++) {
                normals->triangles[i] = model->triangles[i];
            }
            return 1;
        }
    }
    pbwio_free(normals);
    return 0;
}

typedef struct pbwmodel__job {
    const pbwmodel_content *content;
    pbwio_format format;
    int text;
} pbwmodel__job;

/* Numbers of a row, as text in the fewest digits that read back the same, or as they are in memory. */
static void pbwmodel__row(FILE *file, int text, const char *head, const double *a, int a_count, const double *b,
                          int b_count, char between)
{
    int i;
    if (!text) {
        fwrite(a, sizeof *a, (size_t)a_count, file);
        fwrite(b, sizeof *b, (size_t)b_count, file);
        return;
    }
    fputs(head, file);
    for (i = 0; i < a_count + b_count; i++) {
        char number[40];
        number[pbwio__print_number(number, i < a_count ? a[i] : b[i - a_count])] = 0;
        fprintf(file, "%s%c", number, i + 1 < a_count + b_count ? between : '\n');
    }
}

static void pbwmodel__stl(const pbwmodel_content *content, FILE *file, int text)
{
    char head[84] = "triangles";
    uint32_t count = (uint32_t)content->triangle_count;
    size_t i;
    int j, k;
    memcpy(head + 80, &count, 4);
    if (text) {
        fputs("solid triangles\n", file);
    } else {
        fwrite(head, sizeof head, 1, file);
    }
    for (i = 0; i < content->triangle_count; i++) {
        double p[3][3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } }, n[3], length;
        float row[12];
        for (j = 0; j < 3; j++) {
            for (k = 0; k < content->dim; k++) {
                p[j][k] = content->points[(size_t)content->dim * content->triangles[3 * i + (size_t)j] + (size_t)k];
            }
        }
        for (k = 0; k < 3; k++) {
            int a = (k + 1) % 3, b = (k + 2) % 3;
            n[k] = (p[1][a] - p[0][a]) * (p[2][b] - p[0][b]) - (p[1][b] - p[0][b]) * (p[2][a] - p[0][a]);
        }
        length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (k = 0; k < 12; k++) {
            row[k] = (float)(k >= 3 ? p[k / 3 - 1][k % 3] : length > 0 ? n[k] / length : 0);
        }
        if (!text) {
            fwrite(row, sizeof row, 1, file);
            fwrite("\0", 2, 1, file);
            continue;
        }
        for (k = 0; k < 3; k++) {
            n[k] = (double)row[k];
        }
        pbwmodel__row(file, 1, "facet normal ", n, 3, NULL, 0, ' ');
        fputs("outer loop\n", file);
        for (j = 0; j < 3; j++) {
            pbwmodel__row(file, 1, "vertex ", p[j], 3, NULL, 0, ' ');
        }
        fputs("endloop\nendfacet\n", file);
    }
    fputs(text ? "endsolid triangles\n" : "", file);
}

static void pbwmodel__emit(void *user, FILE *file)
{
    const pbwmodel__job *job = (const pbwmodel__job *)user;
    const pbwmodel_content *c = job->content;
    int obj = job->format == PBWIO_OBJ, ply = job->format == PBWIO_PLY, off = job->format == PBWIO_OFF;
    int full = obj || ply || off, normals = c->normals != NULL && !obj && !off ? 3 : 0, k;
    size_t i;
    if (job->format == PBWIO_STL) {
        pbwmodel__stl(c, file, job->text);
        return;
    }
    if (ply) {
        fprintf(file, "ply\nformat %s 1.0\nelement vertex %zu\nproperty double x\nproperty double y\n"
                "property double z\n%s", job->text ? "ascii" : "binary_little_endian", c->point_count,
                normals != 0 ? "property double nx\nproperty double ny\nproperty double nz\n" : "");
        if (c->triangle_count > 0) {
            fprintf(file, "element face %zu\nproperty list uchar int vertex_indices\n", c->triangle_count);
        }
        fputs("end_header\n", file);
    } else if (off) {
        fprintf(file, "OFF\n%zu %zu 0\n", c->point_count, c->triangle_count);
    } else if (job->format == PBWIO_CSV) {
        fprintf(file, "x,y%s%s\n", c->dim == 3 ? ",z" : "", normals != 0 ? ",nx,ny,nz" : "");
    }
    for (i = 0; i < c->point_count; i++) {
        double p[3] = { 0, 0, 0 };
        memcpy(p, c->points + (size_t)c->dim * i, (size_t)c->dim * sizeof *p);
        pbwmodel__row(file, job->text, obj ? "v " : "", p, full ? 3 : c->dim, normals != 0 ? c->normals + 3 * i : p,
                      normals, job->format == PBWIO_CSV ? ',' : ' ');
    }
    for (i = 0; i < c->point_count && obj && c->normals != NULL; i++) {
        pbwmodel__row(file, 1, "vn ", c->normals + 3 * i, 3, NULL, 0, ' ');
    }
    for (i = 0; i < c->triangle_count && full; i++) {
        const pbw_index *t = c->triangles + 3 * i;
        if (!job->text) {
            fputc(3, file);
            fwrite(t, sizeof *t, 3, file);
            continue;
        }
        fputs(obj ? "f" : "3", file);
        for (k = 0; k < 3; k++) {
            fprintf(file, " %u", (unsigned)t[k] + (unsigned)obj);
            if (obj && c->normals != NULL) {
                fprintf(file, "//%u", (unsigned)t[k] + 1);
            }
        }
        fputc('\n', file);
    }
}

extern pbwio_status pbwmodel_write(const char *path, const pbwmodel_content *content, unsigned flags,
                                   pbwio_error *error)
{
    pbwmodel__job job;
    uint16_t one = 1;
    job.content = content;
    job.format = pbwio_format_of(path);
    job.text = flags & PBWIO_TEXT || !(job.format == PBWIO_PLY || job.format == PBWIO_STL)
            || *(unsigned char *)&one == 0;                          /* binary data are little-endian here */
    if (job.format == PBWIO_AUTO || job.format == PBWIO_NODE || job.format > PBWIO_CSV
        || (job.format == PBWIO_STL && content->triangle_count == 0)) {
        if (error != NULL) {
            snprintf(error->text, sizeof error->text, "%.400s: %s", path, job.format == PBWIO_STL
                     ? "there are no triangles" : "no format of that name is written from points and triangles");
        }
        return PBWIO_ERROR_ARGUMENT;
    }
    return pbwio_save(path, pbwmodel__emit, &job, error);
}

#endif /* PBW_MODEL_IMPLEMENTATION */
