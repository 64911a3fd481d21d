/* pbw_model.h - v0.2.0 - surfaces and points with normals, from files and to files - MIT-0

   QUICK START
   In one source file, define PBW_MODEL_IMPLEMENTATION before the include; in all others, only include.
   Needs the implementation of pbw_io.h in the same source file, before it.

       pbwio_cloud cloud = {0}, normals = {0};
       pbwmodel_content content = {0};
       pbwio_error error;
       if (pbwio_read("model.obj", NULL, &cloud, &error) != PBWIO_OK) puts(error.text);
       pbwmodel_read_normals("model.obj", &cloud, &normals);         // where the file has them
       content.dim = cloud.dim;
       content.points = cloud.points;        content.point_count = cloud.count;
       content.triangles = cloud.triangles;  content.triangle_count = cloud.triangle_count;
       if (pbwmodel_write("model.ply", &content, 0, &error) != PBWIO_OK) puts(error.text);
       pbwio_free(&normals);
       pbwio_free(&cloud);

   FUNCTIONS
     pbwmodel_read_normals  the normals that a file has
     pbwmodel_write         writes a surface to a file

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>normals      the normals of a file, read as points
     >>write        a surface as a mesh of triangles

   HOW
     Reads   normals as a second cloud: columns nx ny nz are read as points, and so are the vn lines of .obj.
     Writes  .obj .ply .stl .off .vtu .msh .msh2 .mesh .inp with triangles; .xyz .csv and, with normals or without
             triangles, .obj .ply: points.

   PROMISES  (tests/test_io.c and tests/test_groups.c guard them)
     whole       there is the whole file or none
     all there   groups, edges and columns go to the file as those of a mesh do (pbwio_keeps)
     quiet       no globals, nothing printed, no exit
*/
#ifndef PBW_MODEL_H
#define PBW_MODEL_H
/* ------------------------------------------------------------------------------------------------------
   >>interface    types and functions
   ------------------------------------------------------------------------------------------------------ */
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
    const double *weights;             /* one a point, for .vtu .xyz .csv; NULL = none */
    pbwio_format format;               /* PBWIO_AUTO = by the name of the file */
    const pbwio_output *output;        /* groups, with regions one a triangle, edges, groups of points, columns; NULL
    =
                                          none */
} pbwmodel_content;

/* Reads the normals that a file has beside its points: `vn` of .obj; properties or columns nx ny nz of .ply, .xyz and
   .csv.  normals: points are the normals, triangles their ids for each triangle of the model (none: as the points'
   ids); pbwio_free when done.  Returns whether there are any; if not, normals is empty. */
extern int pbwmodel_read_normals(const char *path, const pbwio_cloud *model, pbwio_cloud *normals);
/* Writes a file whole or not at all; flags: 0 or PBWIO_TEXT. */
extern pbwio_status pbwmodel_write(const char *path, const pbwmodel_content *content, unsigned flags,
                                   pbwio_error *error);

#ifdef __cplusplus
}
#endif
#endif /* PBW_MODEL_H */

#if defined(PBW_MODEL_IMPLEMENTATION) && !defined(PBWMODEL__IMPLEMENTED)
#define PBWMODEL__IMPLEMENTED

#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------------------------------------
   >>normals      The normals of a file, read as points.
   In: the name of a file, the model that was read from it.  Out: normals, and their ids for each triangle.
   Holds: normals has the number of triangles, or of points, of the model; otherwise it is empty.
   ------------------------------------------------------------------------------------------------------ */

/* Rewrites an .obj file: the points become the normals, the corners of faces the ids of normals.  A corner without a
   normal makes it a bad file. */
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
        text = pbwio_load(path, NULL, &size, NULL);
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

/* ------------------------------------------------------------------------------------------------------
   >>write        A surface as a mesh of triangles.
   In: points, triangles, what belongs to them.  Out: a file, or a status and a message.
   Holds: no name of a group is made up.
   ------------------------------------------------------------------------------------------------------ */

extern pbwio_status pbwmodel_write(const char *path, const pbwmodel_content *content, unsigned flags,
                                   pbwio_error *error)
{
    static const pbwio_group no_group = { 2, 0, NULL };
    const pbwio_format format = content->format != PBWIO_AUTO ? content->format : pbwio_format_of(path);
    const int of_mesh = format == PBWIO_VTU || format == PBWIO_MSH || format == PBWIO_MSH2 || format == PBWIO_MESH
                     || format == PBWIO_INP;
    pbwio_output output;
    pbw_mesh mesh;
    if (format == PBWIO_AUTO || format == PBWIO_NODE || (format > PBWIO_CSV && !of_mesh)
        || ((format == PBWIO_STL || of_mesh) && content->triangle_count == 0)) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, path, "%s", format == PBWIO_STL || of_mesh
            ? "there are no triangles" : "no format of that name is written from points and triangles");
    }
    memset(&output, 0, sizeof output);
    memset(&mesh, 0, sizeof mesh);
    if (content->output != NULL) {
        output = *content->output;
        output.keep = NULL;
        output.patches = NULL;
        output.values = NULL;
    }
    output.groups = output.groups != NULL ? output.groups : &no_group;       /* no default names */
    output.format = format;
    output.flags = flags & PBWIO_TEXT;
    mesh.dim = content->dim;
    mesh.points = content->points;
    mesh.weights = content->weights;
    mesh.point_count = content->point_count;
    mesh.simplices = content->triangles;
    mesh.simplex_count = content->triangle_count;
    return pbwio__write(path, &mesh, 1, content->normals, &output, error);
}

#endif /* PBW_MODEL_IMPLEMENTATION */
