/* pbw_io.h - v0.2.0 - reads point clouds and models, writes meshes - MIT-0

   QUICK START
   In one source file, define PBW_IO_IMPLEMENTATION before the include; in all others, only include.

       #define PBW_IMPLEMENTATION
       #include "pbw.h"
       #define PBW_IO_IMPLEMENTATION
       #include "pbw_io.h"

       pbwio_cloud cloud = {0};
       pbw_mesh mesh = {0};
       pbwio_error error;
       if (pbwio_read("scan.ply", NULL, &cloud, &error) != PBWIO_OK) { puts(error.text); return 1; }
       pbw_triangulate(cloud.dim, cloud.points, cloud.weights, cloud.count, NULL, &mesh);
       if (pbwio_write("scan.vtu", &mesh, NULL, &error) != PBWIO_OK) { puts(error.text); return 1; }
       pbw_free(&mesh);
       pbwio_free(&cloud);

   FUNCTIONS
     pbwio_read         reads a file: points, elements, groups, columns
     pbwio_read_memory  the same of bytes in memory
     pbwio_load         the bytes of a file, unpacked
     pbwio_free         frees what is read
     pbwio_write        writes a mesh to a file, whole or not at all
     pbwio_keeps        what files of a format keep of groups, columns, heights, weights
     pbwio_losses       what of a mesh and its groups they lose, in words
     pbwio_renamed      names of groups that .inp and .su2 have as other words
     pbwio_save         writes any text to a file in that way
     pbwio_format_of    the format that the name of a file tells
     pbwio_status_string  a status in words

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>names        names in any case; messages
     >>numbers      text to doubles and back
     >>inflate      Deflate, gzip, zlib: unpacking
     >>reader       lines, fields, counts, memory within the budget
     >>columns      which columns are coordinates
     >>points       points from rows of fields
     >>elements     elements and their groups
     >>polygons     triangles inside the outline of a polygon
     >>facets       triangles of a facet with several outlines and holes
     >>rows         tables, .node, .obj, .off
     >>binary       .stl, .ply
     >>medit        .mesh, .ele, .face, .edge
     >>poly         .poly, .smesh
     >>msh          .msh
     >>vtu          .vtu
     >>vtk          .vtk
     >>inp          .inp: nodes and elements
     >>sets         .inp: sets and surfaces
     >>su2          .su2
     >>json         .json, .geojson
     >>writer       values, rows and forms
     >>groups       regions, patches, edges and points as runs
     >>words        names of groups as words
     >>files        files with groups
     >>formats      the table of all formats; what each keeps
     >>read         a file into a cloud
     >>deflate      packing
     >>write        a mesh into a file

   READS     what                                     columns that can be chosen
     .obj    v and f lines, polygons, negative ids    numbers of the v line
     .ply    ascii and binary, both byte orders, any  properties by name or number
             properties in any order, lists
     .stl    ascii in all spellings, and binary; each -
             triangle has its own three corners
     .off    OFF, COFF, NOFF, STOFF                   numbers of the vertex line
     .node   TetGen and Triangle, 0- or 1-based       x y (z), then attributes, then the marker
     .ele    the simplices; points: the .node file    as .node
             of that name; markers of facets: .face
             and .edge of that name, if there
     .face .edge  with the points of the .node file   as .node
             of that name
     .poly .smesh  TetGen: facets, holes, regions;    as .node
             .poly of Triangle: segments; points of
             their own, or of the .node file
     .msh    Gmsh 2.2 and 4.1, ascii and binary       x y z
     .mesh   Medit, ascii                             x y (z)
     .inp    Abaqus and CalculiX: nodes, elements,    -
             sets, surfaces, of one part
     .su2    one zone                                 -
     .vtu    one piece; ascii, base64 or raw, plain   weights: an array of the points by name
             or compressed by zlib
     .vtk    legacy files, versions 1 to 5.1: grids   as .vtu
             and polygons; ascii and binary
     .json .geojson  arrays of numbers; objects with  numbers in an array, members of an object; before
             x and y; "coordinates"                   these "points:" where several lists may be the points
     .xyz    molecules: count, comment, then rows     symbol x y z, then numbers
             of symbol x y z
     .xyz .csv .txt .tsv .pts .asc .dat               by name if there is a header line, or number;
             separated by blanks, commas, semicolons  a line that starts with # is a comment
       A header may name them otherwise: easting, lon, X_COORD, POINT_X, "x (m)" ... with their partners; elevation,
       height, alt ...  Two pairs of names, or two names of z, are refused.  pbwio_cloud.taken says what was taken.
     Any other name: the content decides.  All of them compressed by gzip, too, with the ending .gz or not.
     Of meshes, triangles, quadrilaterals, polygons are faces, tetrahedra are cells; other elements are passed over.
     A polygon becomes triangles inside its outline; one that is flat, crosses or touches itself becomes a fan.
     A first line of counts is passed if the rows below agree with it, and refused where it may as well be a point.

   WRITES    what                                             text or binary     read by
     .vtu    simplices, quality, point ids                    both               ParaView, VTK
     .msh    simplices and boundary, Gmsh 4.1                 both               Gmsh, DOLFINx
     .msh2   the same, Gmsh 2.2                               text               OpenFOAM, Elmer, GetFEM
     .mesh   simplices and boundary, Medit                    text               FreeFem++, Mmg
     .inp    simplices and boundary, Abaqus                   text               CalculiX, Abaqus
     .su2    simplices and boundary                           text               SU2
     .node .ele .neigh .face (2D: .edge)    from 0, or base   text               TetGen, Triangle
     .ply .stl            3D: the hull; 2D: the triangles     both
     .obj .off            the same                            text
     .xyz .csv            points                              text
     Binary unless PBWIO_TEXT.  All of them compressed by gzip, too, with .gz behind the ending.

   KEEPS     x is kept, - is not: pbwio_keeps, and pbwio_losses in words                    tests/test_groups.c
                                  .vtu .msh .mesh .inp .su2 .ele .face .node .csv .xyz .obj .stl .ply .off
     regions                       x    x    x     x    -    x    -     -     -    -    a    a    -    -
     patches of the hull           x    x    x     x    x    -    x     -     -    -    a    a    -    -
     patches inside                x    x    x     x    -    -    x     -     -    -    -    -    -    -
     edges in groups               x    x    x     b    -    -    -     -     -    -    -    -    -    -
     points in groups              x    x    x     x    -    -    -     x     x    -    -    -    -    -
     names of groups               x    x    -     c    c    -    -     -     -    -    x    x    -    -
     columns of points             d    -    -     -    -    -    -     x     x    -    -    -    x    -
     heights                       x    x    x     x    -    -    -     x     x    x    x    x    x    x
     weights of points             x    -    -     -    -    -    -     x     x    x    -    -    -    -
       a: groups of triangles; of .stl in text only.  b: their points.  c: as words.  d: written, not read.

   PROMISES  (and the test that guards each)
     exact       numbers are read correctly rounded and written so that they read back the same, in every
                 locale                                                                     tests/test_io.c
     says where  a bad file is refused with "name:line: what" or "name: byte N: what"       tests/test_io.c
     bounded     a file of n bytes makes the readers hold at most 8 n bytes + 64 KiB (.poly .smesh: 32 n) beside its
                 own text, n counted unpacked; unpacking needs at most 3 n + 64 KiB; nothing recurses; the stack
                 needed is below 64 KiB
                                                                                            tests/test_io.c
     limited     memory_limit holds in every call, the text of a file included              tests/test_read.c
     safe        no input, however broken, crashes or hangs a reader                        tests/fuzz_io.c
     whole       a file is written under another name and renamed at the end: there is the whole file or
                 none                                                                       tests/test_io.c
     quiet       no globals, nothing printed, no locale set, no exit

   CONVENTIONS
     Positive simplices, as in pbw.h.  Quality is the mean ratio: 1 for the regular simplex, 0 for a flat one.  Facets
     of the hull turn counter-clockwise seen from outside.

     Groups that are read.  0 is no group.  An element in several groups is in the first.
       .msh         physical groups; of a file without such, its entities
       .mesh        references
       .ele         the first attribute;  .face .edge .poly .smesh  the marker, of regions the attribute
       .vtu .vtk    the first of the arrays of integers region, gmsh:physical, medit:ref, su2:tag, material,
                    MaterialIDs, MaterialID, CellEntityIds, CellEntityID, physical, attribute, subdomain, cell_tags,
                    facet_tags; of triangles also patch, of edges also edge, of points marker.  Names are fields of
                    the file, each of a tag and a dimension
       .stl         of text: its solids, if there are several: groups of triangles
       .obj         usemtl, if that names several, else g, else o: groups of triangles
       .csv .txt    groups of points: the column "marker", if it is no coordinate, weight or column to keep
       .inp         sets and surfaces; of points no set of the nodes of a surface of its name.  Of several sets an
                    element is in the last that a section names, else in the last.  A set of all elements is a group
                    if no other set has any of them
       .su2         markers: groups of facets; "ungrouped" is none

     Groups that are written, the same way, .obj and text .stl too.
       .inp         an ELSET; a SURFACE with an NSET of its points; an NSET of the points of edges.  All simplices are
                    the ELSET "DOMAIN", too, all points of the hull the NSET "BOUNDARY", its facets the SURFACE of
                    that name
       .su2         markers
       1. Facets of the hull in no group: left out of .msh and .vtu, the marker "ungrouped" of .su2.
       2. Tags that .msh .inp .su2 cannot have, below 1 or above 10^9: replaced by numbers after the largest.
       3. Names: in .msh .msh2 .vtu .obj .stl .inp .su2.  The last two have an underscore for all but letters, digits,
          points and hyphens.  Where that makes one word of two names, or one that .inp or .su2 have anyway, the later
          name ends with _2 and so on.
       4. Without groups: the simplices are the group "domain", 2, the facets of the hull "boundary", 1, facets
          between regions "interface", 2, edges "edges", 1.
       5. Regions and patches without groups, r and p: the groups r + 1, "region_r", and p + 1, "patch_p"; in .mesh
          the reference of region r is r + 2.

     Columns of points are attributes in .node, arrays in .vtu, columns in .csv, properties in .ply.  The tag of a
     point's group is the marker in .node, the array or column "marker" in .vtu and .csv, the reference in .mesh.
     Other formats of points have neither.
     Heights are the third coordinate of a mesh in the plane, in .node the last attribute; .su2 has none.
     Points keep their ids, so a file can hold points that are corners of nothing: duplicates and hidden points.
     PBWIO_NO_ORPHANS leaves those out and numbers the rest from the first on (solvers want that); .inp and .su2
     always do.  .obj .stl .ply .off of a hull hold the corners of the hull only.
     A number in an .inp file has at most 20 characters, as the format demands, so it may lose its last digits.

   CONFIGURATION MACROS
     PBW_IO_IMPLEMENTATION    in one source file: compile the implementation there
*/
#ifndef PBW_IO_H
#define PBW_IO_H
/* ------------------------------------------------------------------------------------------------------
   >>interface    types and functions
   ------------------------------------------------------------------------------------------------------ */
#ifndef PBW_H
#include "pbw.h"
#endif
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum pbwio_status {
    PBWIO_OK = 0,
    PBWIO_ERROR_FILE,                  /* cannot open, read, write or rename; the disk is full */
    PBWIO_ERROR_FORMAT,                /* the content is not what the format says */
    PBWIO_ERROR_ARGUMENT,              /* unknown format, no such column, mesh without what the format needs */
    PBWIO_ERROR_MEMORY,                /* out of memory, or over memory_limit; what asks for more than the bound above
                                          is ERROR_FORMAT */
    PBWIO_CANCELLED                    /* the progress callback said stop */
} pbwio_status;

typedef struct pbwio_error {           /* filled when a function fails; may be NULL */
    char text[512];                    /* "name:line: what", no newline */
} pbwio_error;

typedef enum pbwio_format {
    PBWIO_AUTO = 0,                    /* reading: by name, then by content; writing: by name */
    PBWIO_OBJ, PBWIO_PLY, PBWIO_STL, PBWIO_OFF, PBWIO_NODE, PBWIO_XYZ, PBWIO_CSV,     /* XYZ, CSV: any table */
    PBWIO_VTU, PBWIO_MSH, PBWIO_MESH, PBWIO_ELE,
    PBWIO_NEIGH,                                                                      /* written only */
    PBWIO_FACE, PBWIO_MSH2, PBWIO_INP, PBWIO_SU2,                                     /* FACE: .edge, too */
    PBWIO_JSON, PBWIO_VTK, PBWIO_POLY                                                 /* read only; POLY: .smesh */
} pbwio_format;

/* A set of elements that a file names or numbers: a region, a patch of the surface, a curve, marked points. */
typedef struct pbwio_group {
    int dim;                           /* of its elements: 3 tetrahedra, 2 triangles, 1 segments, 0 points */
    long long tag;                     /* physical group, reference, attribute or marker; 1, 2, ... where the file has
                                          names only */
    char *name;                        /* NULL: the file has none */
} pbwio_group;

typedef struct pbwio_column {          /* a number at each point: an attribute, a column of a table */
    char *name;                        /* NULL: the file has none */
    double *values;                    /* one a point */
} pbwio_column;

typedef struct pbwio_seed {            /* a place in what facets enclose, in the plane segments */
    double place[3];
    double bound;                      /* of volumes there, in the plane of areas; 0 = none */
    pbw_index group;                   /* index in groups; PBW_NONE = a hole */
} pbwio_seed;

typedef struct pbwio_cloud {           /* start from {0}; pbwio_free when done */
    int dim;                           /* 2 or 3 coordinates a point */
    size_t count;
    double *points;                    /* count*dim, all finite */
    double *weights;                   /* count, or NULL without pbwio_options.weight */
    size_t triangle_count;             /* faces of a model, polygons in triangles; 0 for tables and .node */
    pbw_index *triangles;              /* triangle_count*3 ids of points, each < count */
    size_t tetrahedron_count;          /* of .ele .msh .mesh .vtu; their triangles are faces as above */
    pbw_index *tetrahedra;             /* tetrahedron_count*4 ids of points, turned as the file has them */
    size_t segment_count;              /* lines of meshes */
    pbw_index *segments;               /* segment_count*2 ids of points */
    size_t group_count;                /* what follows is empty where the file has nothing of the kind */
    pbwio_group *groups;               /* in the order of the file; those without an element too */
    pbw_index *tetrahedron_groups, *triangle_groups, *segment_groups, *point_groups;     /* one an element: its
                                          index in groups, PBW_NONE = in none */
    size_t column_count;
    pbwio_column *columns;
    size_t seed_count;
    pbwio_seed *seeds;                 /* of .poly .smesh */
    double *heights;                   /* z of each point, which options.dim = 2 leaves out of points; NULL: the file
                                          has none, or all are 0 */
    int base;                          /* number of the first point in the file: 0 or 1 */
    char dropped[256];                 /* what the file has and the cloud has not, in words; "" = nothing */
    char taken[200];                   /* which columns of a table are the coordinates, in words; "" = no question */
    pbw_memory memory;                 /* private: of the arrays, and their bytes, those of points first */
    size_t capacity[14];
} pbwio_cloud;

typedef struct pbwio_options {         /* NULL or all zero = best defaults */
    pbwio_format format;
    int dim;                           /* 0 = what the file has, 2 = z goes to heights, 3 = refuse a file without z */
    const char *columns;               /* "2,3,4" or "east,north": x,y or x,y,z, numbered from 1 or named; NULL = the
                                          columns with names that stand for x y z, else the first that are neither the
                                          weight nor, in tables, an id */
    const char *weight;                /* the same for the weight; NULL = no weights */
    const char *keep;                  /* columns of tables to keep, the same way; "*": all; NULL: none */
    unsigned flags;                    /* PBWIO_DECIMAL_COMMA | PBWIO_CLOSED_RINGS */
    const pbw_options *build;          /* memory_limit, resize, progress, as in pbw.h; NULL = defaults */
} pbwio_options;

#define PBWIO_CLOSED_RINGS  2u         /* GeoJSON: a ring keeps its last position, which is its first again */
#define PBWIO_DECIMAL_COMMA 1u         /* tables: numbers such as 1,5; columns are set apart by ; or blanks */

#define PBWIO_TEXT       1u            /* text even where the format has a binary form */
#define PBWIO_NO_ORPHANS 2u            /* leave out points that are corners of nothing written */

typedef struct pbwio_output {          /* NULL or all zero = best defaults */
    pbwio_format format;
    unsigned flags;                    /* PBWIO_TEXT | PBWIO_NO_ORPHANS */
    const unsigned char *keep;         /* one a simplex, 0 = leave it out; the hull is that of the rest; NULL = all */
    const double *values;              /* one number a simplex, an array more in .vtu; NULL = none */
    const char *value_name;            /* its name, NULL = "value" */
    const pbw_index *regions;          /* one a simplex: see the conventions; NULL = 0 */
    const pbw_index *patches;          /* one a corner of a simplex, of the facet across from it; NULL = 0 */
    const pbw_index *edges;            /* of a mesh in space: feature edges, two points each; NULL = none */
    size_t edge_count;
    const pbwio_group *groups;         /* if not NULL, regions, patches, edge_groups, point_groups are indices into
                                          it, or PBW_NONE, and files have its tags and names, not r + 1, p + 1 */
    size_t group_count;
    const pbw_index *edge_groups;      /* one an edge; NULL = none */
    const pbw_index *point_groups;     /* one a point; NULL = none */
    const pbwio_column *columns;       /* of points, where the format has such: .vtu .csv .node .ply; NULL = none */
    size_t column_count;
    const double *heights;             /* of a mesh in the plane: z of each point; in .node an attribute, in .su2
                                          nothing; NULL = 0, no z in .mesh .inp .xyz .csv */
    int base;                          /* of .node .ele .neigh .face .edge: number of the first point and element */
    const pbw_options *build;          /* memory_limit, resize, progress, as in pbw.h; NULL = defaults */
} pbwio_output;

enum {                                 /* what files of a format keep beside points and simplices: bits */
    PBWIO_REGIONS = 1, PBWIO_PATCHES = 2,     /* groups of simplices; of facets at the boundary */
    PBWIO_INNER_PATCHES = 4, PBWIO_EDGES = 8, PBWIO_MARKS = 16,       /* of other facets, of edges, of points */
    PBWIO_NAMES = 32,                  /* of groups */
    PBWIO_COLUMNS = 64, PBWIO_HEIGHTS = 128, PBWIO_WEIGHTS = 256
};

/* Reads a file; "-" is the standard input.  cloud: overwritten (what it held is not freed), left empty on failure. */
PBWDEF pbwio_status pbwio_read(const char *path, const pbwio_options *options, pbwio_cloud *cloud,
                               pbwio_error *error);
/* Reads a file that is in memory; name is for its format and for messages.  data is not kept. */
PBWDEF pbwio_status pbwio_read_memory(const char *name, const void *data, size_t size, const pbwio_options *options,
                                      pbwio_cloud *cloud, pbwio_error *error);
/* The whole of a file, unpacked if gzip has packed it, and a 0 behind its `size` bytes; "-" is the standard input.
   options: memory_limit, resize, progress; NULL = defaults.  The caller frees the block, of size + 1 bytes, by
   options.resize, by default free.  Returns NULL on failure. */
PBWDEF char *pbwio_load(const char *path, const pbw_options *options, size_t *size, pbwio_error *error);
/* Frees what a cloud holds and zeroes it; fine on {0}, fine twice.  An array may be taken over, its pointer set to
   NULL, or replaced by one of the same allocator, by default malloc. */
PBWDEF void pbwio_free(pbwio_cloud *cloud);
/* Writes a mesh. */
PBWDEF pbwio_status pbwio_write(const char *path, const pbw_mesh *mesh, const pbwio_output *output,
                                pbwio_error *error);
/* What files of a format keep, of simplices of that many corners, 3 or 4, written with flags: bits as above. */
PBWDEF unsigned pbwio_keeps(pbwio_format format, int corners, unsigned flags);
/* What is lost of a mesh, of simplices of that many corners, and an output in files that keep so much, in words, into
   text, size bytes; "" = nothing. */
PBWDEF void pbwio_losses(unsigned keeps, int corners, const pbw_mesh *mesh, const pbwio_output *output, char *text,
                         size_t size);
/* Which groups of simplices of that many corners, and so on, have other names in .inp and .su2, in words: "a b" is
   a_b; "" = none has. */
PBWDEF void pbwio_renamed(pbwio_format format, int corners, const pbw_mesh *mesh, const pbwio_output *output,
                          char *text, size_t size);
/* Writes any file whole or not at all: emit writes to the stream and need not look for errors.  That is a new file,
   "path.part.PROCESS-NUMBER", so that runs at the same time and files that are there are safe; in the end it is
   renamed to path, or removed if the disk was full.  A file that is replaced gives its mode to the new one; a
   symbolic link stays, and what it leads to is replaced.  "-" is the standard output; that, FIFOs, devices and names
   under /dev are written in place.  What is written to a path that ends in .gz is packed by gzip.  options:
   memory_limit, resize, progress (after emit, and while it packs: if it says stop, there is no file); NULL =
   defaults. */
PBWDEF pbwio_status pbwio_save(const char *path, void (*emit)(void *user, FILE *file), void *user,
                               const pbw_options *options, pbwio_error *error);
/* The format that a name's ending stands for, without .gz behind it; PBWIO_AUTO if none. */
PBWDEF pbwio_format pbwio_format_of(const char *path);
/* What a status means; a pbwio_error says where, too.  Never NULL, never freed. */
PBWDEF const char *pbwio_status_string(pbwio_status status);

#ifdef __cplusplus
}
#endif
#endif /* PBW_IO_H */

#if defined(PBW_IO_IMPLEMENTATION) && !defined(PBWIO__IMPLEMENTED)
#define PBWIO__IMPLEMENTED

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#include <process.h>
#define PBWIO__PROCESS() _getpid()
#else
#include <unistd.h>
#define PBWIO__PROCESS() getpid()
#ifndef __cplusplus
extern ssize_t readlink(const char *path, char *link, size_t size);     /* strict C modes hide it */
#endif
#endif

#if defined(__GNUC__)
#define PBWIO__PRINTF(a, b) __attribute__((format(printf, a, b)))
#else
#define PBWIO__PRINTF(a, b)
#endif

/* ------------------------------------------------------------------------------------------------------
   >>names        Names in any case, and messages with a place.
   In: words of a file, what is wrong with it.  Out: whether two words are the same; the text of a pbwio_error.
   Holds: a message ends with a 0 and fits into its text; of a long path it has the end.
   ------------------------------------------------------------------------------------------------------ */

static int pbwio__lower(int c)
{
    return c >= 'A' && c <= 'Z' ? c + 32 : c;
}

/* Equal up to the case of letters. */
static int pbwio__same(const char *a, size_t a_length, const char *b, size_t b_length)
{
    size_t i = 0;
    while (i < a_length && i < b_length && pbwio__lower(a[i]) == pbwio__lower(b[i])) {
        i++;
    }
    return i == a_length && i == b_length;
}

static void pbwio__message(pbwio_error *error, const char *name, const char *where, const char *format, va_list list)
{
    size_t length = strlen(name), used;
    const char *tail = length > 200 ? name + length - 200 : name;      /* the end of a long path tells more */
    if (error != NULL) {
        snprintf(error->text, sizeof error->text, "%s%s%s ", length > 200 ? "..." : "", tail, where);
        used = strlen(error->text);
        vsnprintf(error->text + used, sizeof error->text - used, format, list);
    }
}

PBWDEF const char *pbwio_status_string(pbwio_status status)
{
    static const char *const texts[] = {
        "done", "a file cannot be opened, read, written or renamed", "the content is not what the format says",
        "an argument is wrong: an unknown format, no such column, a mesh without what the format needs",
        "out of memory, or over the memory limit", "cancelled"
    };
    return (size_t)status < sizeof texts / sizeof texts[0] ? texts[status] : "unknown status";
}

/* Reports progress.  Returns whether the callback ends the call. */
static int pbwio__stops(const pbw_options *build, double done)
{
    return build != NULL && build->progress != NULL
        && build->progress(build->progress_user, PBW_STAGE_WORK, done) != 0;
}

PBWIO__PRINTF(4, 5)
static pbwio_status pbwio__file_error(pbwio_error *error, pbwio_status status, const char *name,
                                      const char *format, ...)
{
    va_list list;
    va_start(list, format);
    pbwio__message(error, name, ":", format, list);
    va_end(list);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>numbers      Decimal text to the nearest double and back.
   In: text, or a double.  Out: the nearest double, or the fewest digits that read back the same.
   Holds: no locale takes part, as no decimal point is given to the C library or taken from it.
   ------------------------------------------------------------------------------------------------------ */

/* Converts a well-formed number from its digits, as an integer and a power of ten, so that no decimal point and no
   locale is involved.  A double or a midpoint of two has at most 767 significant digits; of more digits than
   that it matters only whether the rest is zero. */
static double pbwio__long_number(const char *s, const char *end, char mark, long long exponent)
{
    char digits[840];
    int count = 0, point = 0, rest = 0, negative = *s == '-';
    for (s += *s == '-' || *s == '+'; s < end; s++) {
        if (*s == mark) {
            point = 1;
            continue;
        }
        if (count < 780) {
            exponent -= point;
            if (count > 0 || *s != '0') {
                digits[count++] = *s;
            }
        } else {
            exponent += !point;
            rest |= *s != '0';
        }
    }
    if (count == 0) {
        return negative ? -0.0 : 0.0;
    }
    if (rest) {
        digits[count++] = '1';
        exponent--;
    }
    exponent = exponent > 99999 ? 99999 : exponent < -99999 ? -99999 : exponent;
    snprintf(digits + count, sizeof digits - (size_t)count, "e%d", (int)exponent);
    return negative ? -strtod(digits, NULL) : strtod(digits, NULL);
}

/* 1 if [s, end) is a finite decimal number, with that decimal mark, and nothing else.  Up to 2^53 times a power of
   ten up to 10^22 is one rounding of two exact doubles, so correct (Clinger 1990, "How to read floating point numbers
   accurately"). */
static int pbwio__decimal(const char *s, const char *end, char mark, double *value)
{
    static const double power[] = { 1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14,
                                    1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22 };
    const char *begin = s, *digits_end;
    uint64_t mantissa = 0;
    long long exponent = 0, written = 0;
    int any = 0, point = 0, exact = 1, minus;
    s += s < end && (*s == '-' || *s == '+');
    for (; s < end; s++) {
        unsigned digit = (unsigned)*s - '0';
        if (digit <= 9) {
            any = 1;
            exponent -= point;
            exact &= mantissa < 900719925474099u;
            mantissa = mantissa * 10 + digit;                       /* wraps only where exact is 0 */
        } else if (*s == mark && !point) {
            point = 1;
        } else {
            break;
        }
    }
    digits_end = s;
    if (!any) {
        return 0;
    }
    if (s < end && (*s == 'e' || *s == 'E' || *s == 'd' || *s == 'D')) {     /* Fortran writes 1D0 */
        s++;
        minus = s < end && *s == '-';
        s += s < end && (*s == '-' || *s == '+');
        if (s == end) {
            return 0;
        }
        for (; s < end && (unsigned)*s - '0' <= 9; s++) {
            written = written < 1000000000000 ? written * 10 + (*s - '0') : written;
        }
        written = minus ? -written : written;
        exponent += written;
    }
    if (s != end) {
        return 0;
    }
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD == 0
    if (exact && exponent >= -22 && exponent <= 22) {
        double x = exponent < 0 ? (double)mantissa / power[-exponent] : (double)mantissa * power[exponent];
        *value = *begin == '-' ? -x : x;
        return 1;
    }
#endif
    *value = pbwio__long_number(begin, digits_end, mark, written);
    return *value <= DBL_MAX && *value >= -DBL_MAX;
}

static int pbwio__number(const char *s, const char *end, double *value)
{
    return pbwio__decimal(s, end, '.', value);
}

/* The digits d.ddd times 10^exponent as text.  Returns the length. */
static int pbwio__lay_out(char text[40], int minus, const char *digits, int count, int exponent)
{
    int fixed = exponent >= -5 && exponent <= 16, point = fixed ? exponent + 1 : 1, length = 0, i;
    while (count > 1 && digits[count - 1] == '0') {
        count--;
    }
    if (minus) {
        text[length++] = '-';
    }
    if (point <= 0) {
        text[length++] = '0';
    }
    for (i = point < 0 ? point : 0; i < count || i < point; i++) {
        if (i == point) {
            text[length++] = '.';
        }
        text[length++] = i >= 0 && i < count ? digits[i] : '0';
    }
    return length + (fixed ? 0 : snprintf(text + length, 8, "e%d", exponent));
}

/* Writes x in the fewest digits from 15 to 17 that read back the same, in fewer where it would be longer than
   longest, which is 20 at least.  Returns the length. */
static int pbwio__print_number(char text[40], double x, int longest)
{
    char raw[40], digits[18] = "", shorter[40];
    int count = 0, length, exponent, i, other;
    double back;
    if (!(x - x <= 0)) {                                             /* values of the user may be so */
        return snprintf(text, 40, x > 0 || x < 0 ? "inf" : "nan");
    }
    snprintf(raw, sizeof raw, "%.16e", x);
    for (i = 0; raw[i] != 'e'; i++) {                                /* the locale's point may be any bytes */
        if (raw[i] >= '0' && raw[i] <= '9') {
            digits[count++] = raw[i];
        }
    }
    exponent = atoi(raw + i + 1);
    length = pbwio__lay_out(text, *raw == '-', digits, count, exponent);
    while (count > 15 || length > longest) {
        int up = digits[--count] >= '5';
        for (i = count - 1; up && i >= 0; i--) {
            up = digits[i] == '9';
            digits[i] = (char)(up ? '0' : digits[i] + 1);
        }
        if (up) {                                                    /* 9.99 became 10.0 */
            digits[0] = '1';
            exponent++;
        }
        other = pbwio__lay_out(shorter, *raw == '-', digits, count, exponent);
        if (length <= longest && (!pbwio__number(shorter, shorter + other, &back) || back < x || back > x)) {
            break;
        }
        memcpy(text, shorter, (size_t)other);
        length = other;
    }
    return length;
}

/* ------------------------------------------------------------------------------------------------------
   >>inflate      Deflate (RFC 1951) as gzip (RFC 1952) and zlib (RFC 1950) wrap it.
   In: packed bytes.  Out: a block of unpacked ones.
   Holds: no read beyond the end; copies reach back no farther than the start of their member.
   ------------------------------------------------------------------------------------------------------ */
#define PBWIO__FAST 10                       /* codes of at most so many bits are looked up at once */

typedef struct pbwio__codes {                /* a canonical Huffman code */
    uint16_t count[16], symbol[288];         /* codes of each length; symbols in the order of their codes */
    uint16_t fast[1 << PBWIO__FAST];         /* by the next bits: 16 * symbol + length; 0: the code is longer */
} pbwio__codes;

typedef struct pbwio__inflater {
    const unsigned char *in, *end;
    unsigned char *out;
    size_t used, capacity, start;            /* of out; start: where this member's bytes start */
    uint64_t bits;
    int bit_count, failed;
    pbwio_status status;                     /* why it failed, if the data are not to blame */
    pbw_memory *memory;                      /* NULL: out cannot grow */
    const pbw_options *build;
    pbwio__codes literals, distances;
} pbwio__inflater;

/* The next bits, the first of them lowest; zeros beyond the end. */
static unsigned pbwio__peek_bits(pbwio__inflater *z, int count)
{
    while (z->bit_count < count && z->in < z->end) {
        z->bits |= (uint64_t)*z->in++ << z->bit_count;
        z->bit_count += 8;
    }
    return (unsigned)(z->bits & (((uint64_t)1 << count) - 1));
}

static void pbwio__skip_bits(pbwio__inflater *z, int count)
{
    z->failed |= count > z->bit_count;
    z->bits >>= count;
    z->bit_count = count > z->bit_count ? 0 : z->bit_count - count;
}

static unsigned pbwio__read_bits(pbwio__inflater *z, int count)
{
    unsigned value = pbwio__peek_bits(z, count);
    pbwio__skip_bits(z, count);
    return value;
}

/* Makes a code from the lengths of its symbols; a code that has too many words is refused. */
static void pbwio__make_codes(pbwio__inflater *z, pbwio__codes *codes, const unsigned char *length, int count)
{
    unsigned next[16], first[16], code = 0, i, k, reversed;
    int symbol, left = 1;
    memset(codes, 0, sizeof *codes);
    for (symbol = 0; symbol < count; symbol++) {
        codes->count[length[symbol]]++;
    }
    codes->count[0] = 0;
    for (i = 1, first[0] = next[0] = k = 0; i < 16; i++) {
        code = (code + codes->count[i - 1]) << 1;
        next[i] = code;
        first[i] = k;
        k += codes->count[i];
        left = 2 * left - codes->count[i];
        z->failed |= left < 0;
    }
    for (symbol = 0; symbol < count && !z->failed; symbol++) {
        i = length[symbol];
        if (i != 0) {
            codes->symbol[first[i]++] = (uint16_t)symbol;
            for (k = 0, reversed = 0; k < i; k++) {
                reversed |= (next[i] >> k & 1) << (i - 1 - k);
            }
            for (; i <= PBWIO__FAST && reversed < 1 << PBWIO__FAST; reversed += 1u << i) {
                codes->fast[reversed] = (uint16_t)(16 * symbol + (int)i);
            }
            next[i]++;
        }
    }
}

static int pbwio__symbol(pbwio__inflater *z, const pbwio__codes *codes)
{
    unsigned bits = pbwio__peek_bits(z, 15), fast = codes->fast[bits & ((1 << PBWIO__FAST) - 1)];
    int code = 0, first = 0, at = 0, length;
    if (fast != 0) {
        pbwio__skip_bits(z, (int)(fast & 15));
        return (int)(fast >> 4);
    }
    for (length = 1; length < 16; length++, bits >>= 1) {
        code |= (int)(bits & 1);
        if (code - first < codes->count[length]) {
            pbwio__skip_bits(z, length);
            return codes->symbol[at + code - first];
        }
        at += codes->count[length];
        first = (first + codes->count[length]) << 1;
        code <<= 1;
    }
    z->failed = 1;
    return 0;
}

/* Room for more bytes of output. */
static int pbwio__room(pbwio__inflater *z, size_t more)
{
    if (z->capacity - z->used < more) {
        size_t capacity = z->capacity + z->capacity / 2 + more + 4096;
        if (z->memory == NULL || capacity < z->capacity
            || !pbw_memory_fit(z->memory, &z->out, &z->capacity, capacity, 1)) {
            z->status = z->memory != NULL ? PBWIO_ERROR_MEMORY : z->status;
            z->failed = 1;
            return 0;
        }
    }
    return 1;
}

/* The lengths of the codes of a block: its builtin, or fixed ones. */
static void pbwio__read_codes(pbwio__inflater *z, int fixed)
{
    static const unsigned char order[19] = { 16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15 };
    unsigned char length[320];
    int literals = 288, distances = 30, count, i, symbol, repeat;
    memset(length, 0, sizeof length);
    if (fixed) {
        for (i = 0; i < 288; i++) {
            length[i] = (unsigned char)(i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8);
        }
        memset(length + 288, 5, 30);
    } else {
        literals = 257 + (int)pbwio__read_bits(z, 5);
        distances = 1 + (int)pbwio__read_bits(z, 5);
        count = 4 + (int)pbwio__read_bits(z, 4);
        for (i = 0; i < count; i++) {
            length[order[i]] = (unsigned char)pbwio__read_bits(z, 3);
        }
        pbwio__make_codes(z, &z->literals, length, 19);
        memset(length, 0, sizeof length);
        for (i = 0; i < literals + distances && !z->failed;) {
            symbol = pbwio__symbol(z, &z->literals);
            repeat = symbol < 16 ? 1 : symbol == 16 ? 3 + (int)pbwio__read_bits(z, 2)
                   : symbol == 17 ? 3 + (int)pbwio__read_bits(z, 3) : 11 + (int)pbwio__read_bits(z, 7);
            z->failed |= i + repeat > literals + distances || (symbol == 16 && i == 0);
            for (; repeat > 0 && !z->failed; repeat--, i++) {
                length[i] = (unsigned char)(symbol < 16 ? symbol : symbol == 16 ? length[i - 1] : 0);
            }
        }
        z->failed |= literals > 286 || distances > 30;
    }
    if (!z->failed) {
        pbwio__make_codes(z, &z->literals, length, literals);
        pbwio__make_codes(z, &z->distances, length + literals, distances);
    }
}

static void pbwio__read_block(pbwio__inflater *z)
{
    static const uint16_t length_base[29] = { 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19, 23, 27, 31, 35, 43, 51, 59,
                                              67, 83, 99, 115, 131, 163, 195, 227, 258 };
    int symbol, code, length, extra;
    size_t distance;
    while (!z->failed && (symbol = pbwio__symbol(z, &z->literals)) != 256 && !z->failed) {
        if (symbol < 256) {
            if (pbwio__room(z, 1)) {
                z->out[z->used++] = (unsigned char)symbol;
            }
            continue;
        }
        symbol -= 257;
        if (symbol > 28) {
            z->failed = 1;
            return;
        }
        extra = symbol < 8 || symbol == 28 ? 0 : symbol / 4 - 1;
        length = length_base[symbol] + (int)pbwio__read_bits(z, extra);
        code = pbwio__symbol(z, &z->distances);
        if (code > 29) {
            z->failed = 1;
            return;
        }
        extra = code < 4 ? 0 : code / 2 - 1;
        distance = (code < 4 ? (size_t)code + 1 : ((size_t)(2 + code % 2) << extra) + 1) + pbwio__read_bits(z, extra);
        z->failed |= distance > z->used - z->start;
        if (!z->failed && pbwio__room(z, (size_t)length)) {
            for (; length > 0; length--, z->used++) {                /* byte by byte: it may overlap */
                z->out[z->used] = z->out[z->used - distance];
            }
        }
    }
}

/* Appends what a Deflate stream holds to out; in is then behind its last byte. */
static void pbwio__inflate(pbwio__inflater *z)
{
    int last = 0, kind;
    size_t length;
    z->bits = 0;
    z->bit_count = 0;
    z->start = z->used;
    while (!last && !z->failed) {
        if (pbwio__stops(z->build, 0)) {
            z->status = PBWIO_CANCELLED;
            z->failed = 1;
            return;
        }
        last = (int)pbwio__read_bits(z, 1);
        kind = (int)pbwio__read_bits(z, 2);
        if (kind == 0) {
            pbwio__skip_bits(z, z->bit_count % 8);
            length = pbwio__read_bits(z, 16);
            z->failed |= (pbwio__read_bits(z, 16) ^ length) != 0xffff;
            z->in -= z->bit_count / 8;
            z->bits = 0;
            z->bit_count = 0;
            z->failed |= length > (size_t)(z->end - z->in);
            if (!z->failed && (length == 0 || pbwio__room(z, length))) {
                memcpy(z->out + z->used, z->in, length);
                z->used += length;
                z->in += length;
            }
        } else {
            z->failed |= kind == 3;
            if (!z->failed) {
                pbwio__read_codes(z, kind == 1);
                pbwio__read_block(z);
            }
        }
    }
    z->in -= z->bit_count / 8;
}

/* The check sum of what has crc, 0 for nothing, and more behind it. */
static uint32_t pbwio__crc(uint32_t crc, const unsigned char *data, size_t size)
{
    uint32_t table[256];
    size_t i;
    int k;
    crc = ~crc;
    for (i = 0; i < 256; i++) {
        table[i] = (uint32_t)i;
        for (k = 0; k < 8; k++) {
            table[i] = table[i] >> 1 ^ (table[i] & 1 ? 0xedb88320 : 0);
        }
    }
    for (i = 0; i < size; i++) {
        crc = crc >> 8 ^ table[(crc ^ data[i]) & 255];
    }
    return ~crc;
}

static uint32_t pbwio__word(const unsigned char *s)                  /* of 4 bytes, the lowest first */
{
    return (uint32_t)s[0] | (uint32_t)s[1] << 8 | (uint32_t)s[2] << 16 | (uint32_t)s[3] << 24;
}

/* Passes the header of a gzip member.  Returns whether it is one. */
static int pbwio__gzip_header(pbwio__inflater *z)
{
    int flags, text;
    if (z->end - z->in < 18 || z->in[0] != 0x1f || z->in[1] != 0x8b || z->in[2] != 8) {
        return 0;
    }
    flags = z->in[3];
    z->in += 10;
    if (flags & 4) {                                                 /* extra fields */
        size_t length = (size_t)z->in[0] | (size_t)z->in[1] << 8;
        if ((size_t)(z->end - z->in) < length + 2) {
            return 0;
        }
        z->in += length + 2;
    }
    for (text = 0; text < ((flags & 8) != 0) + ((flags & 16) != 0); text++) {        /* name, comment */
        while (z->in < z->end && *z->in != 0) {
            z->in++;
        }
        z->in += z->in < z->end;
    }
    z->in += flags & 2 && z->end - z->in > 1 ? 2 : 0;
    return 1;
}

typedef PBW_ARRAY(char) pbwio__bytes;

/* Unpacks a .gz file, of one member or several.  What follows the last member, such as the zeros of tapes, does not
   matter. */
static pbwio_status pbwio__gunzip(const char *name, const pbwio__bytes *packed, pbw_memory *memory,
                                  const pbw_options *build, pbwio__bytes *out, pbwio_error *error)
{
    pbwio__inflater *z = (pbwio__inflater *)pbw_memory_resize(memory, NULL, 0, 1, sizeof *z);
    pbwio_status status = PBWIO_OK;
    int members = 0;
    if (z == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_MEMORY, name, "out of memory");
    }
    memset(z, 0, sizeof *z);
    z->in = (const unsigned char *)packed->at;
    z->end = z->in + packed->count;
    z->memory = memory;
    z->build = build;
    pbwio__room(z, 1);                                               /* a block even for no bytes */
    for (; !z->failed && (members == 0 || (z->end - z->in >= 2 && z->in[0] == 0x1f && z->in[1] == 0x8b)); members++) {
        z->failed |= !pbwio__gzip_header(z);
        if (!z->failed) {
            pbwio__inflate(z);
        }
        z->failed |= z->end - z->in < 8;
        if (!z->failed && (pbwio__word(z->in) != pbwio__crc(0, z->out + z->start, z->used - z->start)
                           || pbwio__word(z->in + 4) != (uint32_t)(z->used - z->start))) {
            z->failed = 1;
        }
        z->in += z->failed ? 0 : 8;
    }
    if (z->failed) {
        status = pbwio__file_error(error, z->status != PBWIO_OK ? z->status : PBWIO_ERROR_FORMAT, name, "%s",
                                   z->status == PBWIO_ERROR_MEMORY ? "out of memory"
                                   : z->status == PBWIO_CANCELLED ? "cancelled" : "the compressed data are damaged");
        (void)pbw_memory_fit(memory, &z->out, &z->capacity, 0, 1);
    }
    out->at = (char *)z->out;
    out->count = z->failed ? 0 : z->used;
    out->capacity = z->capacity;
    (void)pbw_memory_resize(memory, z, 1, 0, sizeof *z);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>reader       Lines, fields and counts of a text; blocks within the budget.
   In: the whole file in memory.  Out: its lines and fields one after the other; the first failure, with its place.
   Holds: every pointer stays in [begin, end]; held <= budget; after a failure there are no more lines and fields, so
   that loops end.
   ------------------------------------------------------------------------------------------------------ */
#define PBWIO__MOST_COLUMNS 256

/* The arrays of a cloud by their capacities: elements and their groups by dimension. */
enum { PBWIO__OF_ELEMENTS, PBWIO__OF_MEMBERS = 4, PBWIO__OF_WEIGHTS = 8, PBWIO__OF_HEIGHTS, PBWIO__OF_GROUPS,
       PBWIO__OF_COLUMNS, PBWIO__OF_SEEDS, PBWIO__OF_VALUES };      /* values: of each column */

typedef struct pbwio__field { const char *begin, *end; } pbwio__field;

typedef struct pbwio__polygon { pbw_index first, corners; } pbwio__polygon;     /* first: triangle of its fan */

typedef struct pbwio__reader {
    pbwio_status status;
    const char *name, *begin, *at, *end;     /* at: where the next line or binary value starts */
    const char *line, *line_end, *cursor;    /* the current line without its end; where its next field starts */
    size_t line_number;                      /* 0 where there are no lines: in binary data */
    size_t names_line;                       /* the line that names the columns, 0 = there is none */
    int separator;                           /* ',' or ';', 0 = blanks */
    char mark;                               /* of decimals: '.' or ',' */
    int joined, over;                        /* this line is continued with backslashes; has no more fields */
    int column[4], last_column;              /* where x, y, z and the weight are, from 0; -1 = nowhere.  In 2D z is
                                                the height, which rows may lack: then there are no heights */
    int known;                               /* the columns of coordinates have known names or were chosen */
    int marker;                              /* 1 + the column of a table with groups of points; 0: none */
    pbwio__field marked;                     /* the marker of the point at hand; begin NULL: none */
    unsigned char kept[PBWIO__MOST_COLUMNS]; /* of a column of the file: 1 + its index in cloud->columns; 0: none */
    const pbwio_options *options;
    pbwio_cloud *cloud;
    size_t point_capacity, held, budget;     /* point_capacity: how many points are announced */
    const char *report_at;                   /* where progress is due; NULL: nowhere */
    int pass, passes;                        /* through the file: this one, of so many; 0: one */
    pbw_index group[4];                      /* of elements of that dimension that come next; PBW_NONE: none */
    pbw_index *group_table;                  /* indices of groups by hashes of their dimension and tag, or name */
    size_t group_table_size;                 /* 0 or a power of two, above twice their number */
    size_t fan[2];                           /* the first and the last corner of the polygon at hand */
    PBW_ARRAY(pbwio__polygon) polygons;      /* of more than three corners */
    PBW_ARRAY(unsigned char) midpoints;      /* per point: 1 in the middle of an edge or facet; at NULL: none */
    pbwio_error *error;
    char shown[32];                          /* a field for a message */
    char unread[120];                        /* names of data that the cloud does not keep */
} pbwio__reader;

PBWIO__PRINTF(3, 4)
static void pbwio__fail(pbwio__reader *r, pbwio_status status, const char *format, ...)
{
    char where[40];
    va_list list;
    if (r->status != PBWIO_OK) {
        return;
    }
    if (r->line_number != 0) {
        snprintf(where, sizeof where, ":%zu:", r->line_number);
    } else {
        snprintf(where, sizeof where, ": byte %zu:", (size_t)(r->at - r->begin));
    }
    va_start(list, format);
    pbwio__message(r->error, r->name, where, format, list);
    va_end(list);
    r->status = status;
}

/* Says in cloud->dropped what the cloud does not keep. */
PBWIO__PRINTF(2, 3)
static void pbwio__report_dropped(pbwio__reader *r, const char *format, ...)
{
    char *text = r->cloud->dropped;
    size_t used = strlen(text);
    va_list list;
    va_start(list, format);
    if (used > 0 && used + 2 < sizeof r->cloud->dropped) {
        strcpy(text + used, "; ");
        used += 2;
    }
    vsnprintf(text + used, sizeof r->cloud->dropped - used, format, list);
    va_end(list);
}

/* The same, once for each text. */
static void pbwio__report_once(pbwio__reader *r, const char *what)
{
    if (strstr(r->cloud->dropped, what) == NULL) {
        pbwio__report_dropped(r, "%s", what);
    }
}

/* Reports progress and sets where it is due next. */
static void pbwio__report(pbwio__reader *r)
{
    enum { STEP = 65536 };
    const double done = r->pass + (double)(r->at - r->begin) / (double)(r->end - r->begin);
    r->report_at = r->end - r->at > STEP ? r->at + STEP : NULL;
    if (pbwio__stops(r->options->build, done / (r->passes > 0 ? r->passes : 1))) {
        pbwio__fail(r, PBWIO_CANCELLED, "cancelled");
    }
}

/* Blocks within the budget; while a block grows, both its sizes count. */
static void *pbwio__resize(pbwio__reader *r, void *ptr, size_t old_count, size_t count, size_t size)
{
    void *block = NULL;
    if (count > r->budget / size || count * size > r->budget - r->held) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "a count or an id is too large for the size of the file");
        return NULL;
    }
    block = pbw_memory_resize(&r->cloud->memory, ptr, old_count, count, size);
    if (block == NULL) {
        pbwio__fail(r, PBWIO_ERROR_MEMORY, "out of memory");
        return NULL;
    }
    r->held = r->held + count * size - old_count * size;
    return block;
}

static void pbwio__release(pbwio__reader *r, void *ptr, size_t count, size_t size)
{
    if (ptr != NULL) {
        (void)pbw_memory_resize(&r->cloud->memory, ptr, count, 0, size);
        r->held -= count * size;
    }
}

/* Resizes an array to `wanted` items; array: the address of a pointer.  Returns 0, and leaves it, on failure. */
static int pbwio__fit(pbwio__reader *r, void *array, size_t *capacity, size_t wanted, size_t size)
{
    void *block;
    memcpy(&block, array, sizeof block);
    block = pbwio__resize(r, block, *capacity, wanted, size);
    if (block != NULL) {
        memcpy(array, &block, sizeof block);
        *capacity = wanted;
    }
    return block != NULL;
}

/* PBWIO__PUSH puts an item behind the last of a PBW_ARRAY, PBWIO__RELEASE frees it: within the budget. */
#define PBWIO__PUSH(r, array, item) \
    (((array).count < (array).capacity \
      || pbwio__fit(r, &(array).at, &(array).capacity, (array).capacity + (array).capacity / 2 + 16, \
                    sizeof *(array).at)) \
     && ((array).at[(array).count] = (item), ++(array).count))
#define PBWIO__RELEASE(r, array) pbwio__release(r, (array).at, (array).capacity, sizeof *(array).at)

/* Resizes one of the cloud's arrays. */
static int pbwio__fit_cloud(pbwio__reader *r, int which, void *array, size_t wanted, size_t size)
{
    size_t *capacity = r->cloud->capacity + which, items = *capacity / size;
    const int done = pbwio__fit(r, array, &items, wanted, size);
    *capacity = items * size;
    return done;
}

/* A structure of zeros, which does not count in the budget; freed by pbw_memory_resize. */
static void *pbwio__structure(pbwio__reader *r, size_t size)
{
    void *block = pbw_memory_resize(&r->cloud->memory, NULL, 0, 1, size);
    if (block == NULL) {
        pbwio__fail(r, PBWIO_ERROR_MEMORY, "out of memory");
    } else {
        memset(block, 0, size);
    }
    return block;
}

/* A text up to its first 0, with a 0 behind it: its size is that of the block. */
static char *pbwio__copy(pbwio__reader *r, const char *text, size_t length)
{
    const char *zero = (const char *)memchr(text, 0, length);
    char *copy;
    length = zero != NULL ? (size_t)(zero - text) : length;
    copy = (char *)pbwio__resize(r, NULL, 0, length + 1, 1);
    if (copy != NULL) {
        memcpy(copy, text, length);
        copy[length] = 0;
    }
    return copy;
}

static int pbwio__line(pbwio__reader *r)
{
    const char *stop;
    if (r->report_at != NULL && r->at >= r->report_at) {
        pbwio__report(r);
    }
    if (r->at == r->end || r->status != PBWIO_OK) {
        return 0;
    }
    stop = (const char *)memchr(r->at, '\n', (size_t)(r->end - r->at));
    stop = stop == NULL ? r->end : stop;
    r->line = r->cursor = r->at;
    r->at = stop + (stop < r->end);
    r->line_end = stop - (stop > r->line && stop[-1] == '\r');
    r->line_number++;
    r->joined = r->over = 0;
    return 1;
}

static int pbwio__blank(const pbwio__reader *r, char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r') || (c == '\\' && r->joined);
}

/* The next line that is neither empty nor a comment. */
static int pbwio__row_line(pbwio__reader *r)
{
    const char *s;
    while (pbwio__line(r)) {
        for (s = r->line; s < r->line_end && pbwio__blank(r, *s); s++) {
        }
        if (s < r->line_end && *s != '#') {
            return 1;
        }
    }
    return 0;
}

/* The next field of the line, without the blanks around it; 0 at the end.  Between separators it may be empty. */
static int pbwio__next(pbwio__reader *r, pbwio__field *field)
{
    const char *s = r->cursor, *end = r->line_end, *quote;
    field->begin = field->end = s;
    if (r->over || r->status != PBWIO_OK) {
        return 0;
    }
    while (s < end && pbwio__blank(r, *s) && *s != r->separator) {
        s++;
    }
    field->begin = field->end = s;
    if (r->separator == 0) {
        if (s == end || *s == '#') {
            return 0;
        }
        while (s < end && !pbwio__blank(r, *s)) {
            s++;
        }
        field->end = r->cursor = s;
        return 1;
    }
    quote = s < end && *s == '"' ? (const char *)memchr(s + 1, '"', (size_t)(end - s - 1)) : NULL;
    for (s = quote == NULL ? s : quote; s < end && *s != r->separator; s++) {
    }
    r->over = s == end;
    r->cursor = s + !r->over;
    while (s > field->begin && pbwio__blank(r, s[-1])) {
        s--;
    }
    field->begin += quote != NULL && quote == s - 1;
    field->end = s - (quote != NULL && quote == s - 1);
    return 1;
}

/* Whether the line has more fields. */
static int pbwio__has_more(const pbwio__reader *r)
{
    pbwio__reader ahead = *r;
    pbwio__field field;
    return pbwio__next(&ahead, &field);
}

static int pbwio__is_gz(const char *path)
{
    const size_t length = strlen(path);
    return length > 3 && pbwio__same(path + length - 3, 3, ".gz", 3);
}

/* The ending of a name, without its dot, and without .gz behind it; empty if there is none. */
static pbwio__field pbwio__ending(const char *path)
{
    const char *end = path + strlen(path) - (pbwio__is_gz(path) ? 3 : 0);
    pbwio__field ending;
    for (ending.begin = end; ending.begin > path && strchr("./\\", ending.begin[-1]) == NULL; ending.begin--) {
    }
    ending.end = ending.begin > path && ending.begin[-1] == '.' ? end : ending.begin;
    return ending;
}

static int pbwio__is(pbwio__field field, const char *word)
{
    return pbwio__same(field.begin, (size_t)(field.end - field.begin), word, strlen(word));
}

/* Whether a list of words with blanks between them, and around it or not, has that one. */
static int pbwio__lists(const char *words, pbwio__field word)
{
    size_t length;
    for (; *words != 0; words += length) {
        words += *words == ' ';
        length = strcspn(words, " ");
        if (length > 0 && pbwio__same(word.begin, (size_t)(word.end - word.begin), words, length)) {
            return 1;
        }
    }
    return 0;
}

/* A field for a message: short, and without bytes that a terminal would act on; the next call overwrites it. */
static const char *pbwio__show(pbwio__reader *r, pbwio__field field)
{
    size_t length = (size_t)(field.end - field.begin), i;
    for (i = 0; i < length && i < 24; i++) {
        r->shown[i] = field.begin[i] >= ' ' && field.begin[i] <= '~' ? field.begin[i] : '?';
    }
    strcpy(r->shown + i, length > 24 ? "..." : "");
    return r->shown;
}

/* Adds a name to the list of data that the cloud does not keep. */
static void pbwio__report_unread(pbwio__reader *r, pbwio__field name)
{
    const size_t used = strlen(r->unread);
    const char *text = used < sizeof r->unread - 40 ? pbwio__show(r, name) : "...";
    if (strstr(r->unread, "...") == NULL && strstr(r->unread, text) == NULL) {
        snprintf(r->unread + used, sizeof r->unread - used, "%s%s", used > 0 ? ", " : "", text);
    }
}

/* A count or an id: digits only, at most 18 of them. */
static int pbwio__natural(pbwio__field field, long long *value)
{
    const char *s = field.begin;
    for (*value = 0; s < field.end && (unsigned)*s - '0' <= 9 && s - field.begin < 18; s++) {
        *value = *value * 10 + (*s - '0');
    }
    return s == field.end && s > field.begin;
}

/* Reads the next field as a natural number; what: its name in messages. */
static long long pbwio__count(pbwio__reader *r, const char *what)
{
    long long value = 0;
    pbwio__field field;
    if (!pbwio__next(r, &field)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the line ends where the %s should be", what);
    } else if (!pbwio__natural(field, &value)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a %s", pbwio__show(r, field), what);
    }
    return value;
}

/* The column of that name or number, from 0; -1 if there is none. */
static int pbwio__find(const pbwio__field *names, int count, const char *name, size_t length)
{
    pbwio__field wanted;
    long long number;
    int i;
    for (i = 0; i < count; i++) {
        if (pbwio__same(names[i].begin, (size_t)(names[i].end - names[i].begin), name, length)) {
            return i;
        }
    }
    wanted.begin = name;
    wanted.end = name + length;
    return pbwio__natural(wanted, &number) && number >= 1 && number <= 1000000 ? (int)number - 1 : -1;
}

/* Reports an unknown name, with some of the names that exist. */
static void pbwio__no_column(pbwio__reader *r, const char *name, size_t length, const pbwio__field *names, int count)
{
    char text[300];
    size_t used;
    int i;
    used = (size_t)snprintf(text, sizeof text, "there is no column \"%.*s\"%s", length < 40 ? (int)length : 40, name,
                            count == 0 ? ": no line names the columns" : "");
    for (i = 0; i < count && used < sizeof text - 60; i++) {
        const int size = (int)(names[i].end - names[i].begin);
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%.*s", i == 0 ? "; there are " : ", ",
                                 size < 40 ? size : 40, names[i].begin);
    }
    snprintf(text + used, sizeof text - used, "%s", i < count ? ", ..." : "");
    if (r->names_line != 0) {
        r->line_number = r->names_line;
        pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "%s", text);
    } else if (r->status == PBWIO_OK) {
        r->status = pbwio__file_error(r->error, PBWIO_ERROR_ARGUMENT, r->name, "%s", text);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>columns      Which columns are coordinates, the weight, or kept.
   In: the names of the columns or their number; the options.  Out: r->column and r->kept; what was taken, in words.
   Holds: of columns that may as well be others none is taken: the file is refused, and the message lists them.
   ------------------------------------------------------------------------------------------------------ */

/* Names of x and y that belong together, then names of z and of ids, all as pbwio__plain_name makes them. */
static const char *const pbwio__pairs[][2] = {
    { "x", "y" },
    { "easting east utme utmeasting rechtswert", "northing north utmn utmnorthing hochwert" },
    { "lon long lng longitude decimallongitude", "lat latitude decimallatitude" },
    { "xcoord xcoordinate coordx coordinatex pointx posx xpos positionx xposition utmx xutm points0",
      "ycoord ycoordinate coordy coordinatey pointy posy ypos positiony yposition utmy yutm points1" },
    { "e", "n" }
};
static const char pbwio__z_names[] = "z elevation elev height altitude alt zcoord zcoordinate coordz coordinatez "
    "pointz posz zpos positionz zposition points2 utmz";
static const char pbwio__id_names[] = "id fid gid oid uid uuid objectid ogcfid featureid index idx row rowid key no "
    "nr num number pid ptid pointid pointno nodeid stationid siteid unnamed0 name label code";

/* A name without case, signs, blanks, and the unit behind it: "X_Coord (m)" is "xcoord".  Returns it in text. */
static pbwio__field pbwio__plain_name(pbwio__field name, char text[32])
{
    const char *s;
    pbwio__field plain, word;
    char *end = text, *start = text;         /* start: of the last word */
    for (s = name.begin; s < name.end && end - text < 31 && (end == text || (*s != '(' && *s != '[')); s++) {
        const int c = pbwio__lower(*s);
        if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || (unsigned char)c > 127) {
            *end++ = (char)c;
        } else {
            start = end;
        }
    }
    word.begin = start;
    word.end = end;
    plain.begin = text;
    plain.end = start > text && pbwio__lists("m mm cm km ft deg degree degrees dd meter meters metre metres", word)
              ? start : end;
    return plain;
}

static int pbwio__is_id(pbwio__field name)
{
    char text[32];
    const pbwio__field plain = pbwio__plain_name(name, text);
    return plain.begin == plain.end || pbwio__lists(pbwio__id_names, plain);
}

/* How many columns but the weight have a name of a list, and the first of them; plain: in plain form. */
static int pbwio__columns_named(const pbwio__field *names, int count, int weight, int plain, const char *list,
                                int *column)
{
    char text[32];
    int found = 0, i;
    for (i = count - 1; i >= 0; i--) {
        if (i != weight && pbwio__lists(list, plain ? pbwio__plain_name(names[i], text) : names[i])) {
            *column = i;
            found++;
        }
    }
    return found;
}

/* Refuses a table where several columns may be coordinates, those with names of the lists. */
static void pbwio__ambiguous(pbwio__reader *r, const pbwio__field *names, int count, const char *const *lists,
                             int list_count)
{
    char text[256] = "", plain[32];
    size_t used = 0;
    int i, k, is;
    for (i = 0; i < count && used < sizeof text - 60; i++) {
        for (k = is = 0; k < list_count; k++) {
            is |= pbwio__lists(lists[k], pbwio__plain_name(names[i], plain));
        }
        if (is) {
            const int length = (int)(names[i].end - names[i].begin);
            used += (size_t)snprintf(text + used, sizeof text - used, "%s%.*s (%d)", used > 0 ? ", " : "",
                                     length < 40 ? length : 40, names[i].begin, i + 1);
        }
    }
    r->line_number = r->names_line;
    pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "several columns may be %s: %s; choose by names or numbers (--columns)",
                list_count == 1 ? "z" : "x and y", text);
}

/* Finds x, y and z by the names that stand for them, into r->column; but for tables only x, y and z themselves.
   Returns how many there are: 0, 2 or 3. */
static int pbwio__known_columns(pbwio__reader *r, const pbwio__field *names, int count, int weight)
{
    static const char *const z_names[] = { pbwio__z_names };
    const int groups = (int)(sizeof pbwio__pairs / sizeof pbwio__pairs[0]), table = r->names_line != 0;
    int pairs = 0, p, x, y, *column = r->column;
    for (p = -1; p < (table ? groups : 0) && (pairs == 0 || (p > 1 && p < groups - 1)); p++) {
        const int xs = pbwio__columns_named(names, count, weight, p >= 0, pbwio__pairs[p < 0 ? 0 : p][0], &x);
        const int ys = pbwio__columns_named(names, count, weight, p >= 0, pbwio__pairs[p < 0 ? 0 : p][1], &y);
        if (xs > 0 && ys > 0) {
            pairs += xs * ys;
            column[0] = x;
            column[1] = y;
        }
    }
    if (pairs == 0) {
        return 0;
    }
    if (table && pairs > 1) {
        pbwio__ambiguous(r, names, count, pbwio__pairs[0], 2 * groups);
    }
    p = pbwio__columns_named(names, count, weight, 0, "z", column + 2);
    p = p == 0 && table ? pbwio__columns_named(names, count, weight, 1, pbwio__z_names, column + 2) : p;
    if (table && p > 1 && r->options->dim != 2) {
        pbwio__ambiguous(r, names, count, z_names, 1);
    }
    column[2] = p > 1 && table ? -1 : column[2];
    return column[2] >= 0 ? 3 : 2;
}

/* Says which columns are the coordinates, unless they are named x, y, z, or are all that there are. */
static void pbwio__report_columns(pbwio__reader *r, const pbwio__field *names, int count, int column_count)
{
    char *text = r->cloud->taken;
    const size_t size = sizeof r->cloud->taken;
    int k, asked = count == 0 && column_count > r->cloud->dim;
    for (k = 0; k < 3; k++) {
        const char letter = "xyz"[k];
        const int column = r->column[k];
        asked |= column >= 0 && column < count && !pbwio__same(names[column].begin, (size_t)(names[column].end
                                                               - names[column].begin), &letter, 1);
    }
    for (k = 0; k < 3 && asked && r->status == PBWIO_OK; k++) {
        const int column = r->column[k];
        const size_t used = strlen(text);
        if (column >= 0) {
            snprintf(text + used, size - used, "%s%c = column %d%s%s%s", k > 0 ? ", " : "", "xyz"[k], column + 1,
                     column < count ? " (" : "", column < count ? pbwio__show(r, names[column]) : "",
                     column < count ? ")" : "");
        }
    }
    if (text[0] != 0 && !r->known) {
        snprintf(text + strlen(text), size - strlen(text), count > 0 ? ": no known names, the first that are no ids"
                 : ": the first");
    }
}

/* Room for the values of a column. */
static double *pbwio__column_values(pbwio__reader *r)
{
    r->cloud->capacity[PBWIO__OF_VALUES] = r->point_capacity * sizeof(double);
    return (double *)pbwio__resize(r, NULL, 0, r->point_capacity, sizeof(double));
}

/* Chooses the columns that the cloud keeps, with room for their values.  first: the fields of the first row. */
static void pbwio__keep_columns(pbwio__reader *r, const pbwio__field *names, int name_count,
                                const pbwio__field *first, int count)
{
    const char *s = r->options->keep;
    int column, kept = 0, texts = 0;
    double value;
    if (s == NULL) {
        return;
    }
    for (column = 0; column < count && strcmp(s, "*") == 0; column++) {
        const int other = column != r->column[0] && column != r->column[1] && column != r->column[2]
                       && column != r->column[3] && column + 1 != r->marker;
        r->kept[column] = other && pbwio__decimal(first[column].begin, first[column].end, r->mark, &value);
        texts += other && !r->kept[column];
    }
    if (texts > 0) {
        pbwio__report_dropped(r, "%d column%s of text", texts, texts == 1 ? "" : "s");
    }
    while (*s != 0 && strcmp(s, "*") != 0 && r->status == PBWIO_OK) {
        const size_t length = strcspn(s, ",");
        column = pbwio__find(names, name_count, s, length);
        if (column < 0) {
            pbwio__no_column(r, s, length, names, name_count);
        } else if (column >= count) {
            pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "column %d is needed, there are %d", column + 1, count);
        } else {
            r->kept[column] = 1;
        }
        s += length + (s[length] == ',');
    }
    for (column = 0; column < count; column++) {
        kept += r->kept[column];
    }
    if (kept > 0) {
        (void)pbwio__fit_cloud(r, PBWIO__OF_COLUMNS, &r->cloud->columns, (size_t)kept, sizeof(pbwio_column));
    }
    for (column = 0; column < count && r->cloud->columns != NULL; column++) {
        if (r->kept[column]) {
            pbwio_column *c = r->cloud->columns + r->cloud->column_count++;
            r->kept[column] = (unsigned char)r->cloud->column_count;
            c->values = pbwio__column_values(r);
            c->name = column < name_count ? pbwio__copy(r, names[column].begin,
                                                        (size_t)(names[column].end - names[column].begin)) : NULL;
            r->last_column = column > r->last_column ? column : r->last_column;
        }
    }
}

/* Decides which columns are x, y, z and the weight.  names: of the columns, name_count of them, NULL = x y z;
   column_count: how many columns a row has, 0 = three or more, the rows will tell. */
static void pbwio__choose(pbwio__reader *r, const pbwio__field *names, int name_count, int column_count)
{
    static const char letters[] = "xyz";
    const pbwio_options *o = r->options;
    pbwio__field xyz[3];
    const char *s;
    int dim, i, k, *column = r->column, weight = -1;
    for (k = 0; k < 3; k++) {
        xyz[k].begin = letters + k;
        xyz[k].end = letters + k + 1;
        column[k] = -1;
    }
    names = names == NULL ? xyz : names;
    r->known = 1;
    if (o->weight != NULL && (weight = pbwio__find(names, name_count, o->weight, strlen(o->weight))) < 0) {
        pbwio__no_column(r, o->weight, strlen(o->weight), names, name_count);
    }
    if (o->columns != NULL) {
        for (s = o->columns, dim = 0; dim < 3; s++) {
            size_t length = strcspn(s, ",");
            column[dim] = pbwio__find(names, name_count, s, length);
            if (column[dim++] < 0) {
                pbwio__no_column(r, s, length, names, name_count);
            }
            s += length;
            if (*s == 0) {
                break;
            }
        }
    } else if ((dim = pbwio__known_columns(r, names, name_count, weight)) == 0) {
        r->known = 0;
        for (i = 0; i < (column_count == 0 ? 3 : column_count) && dim < 3; i++) {
            if (i != weight && (r->names_line == 0 || i >= name_count || !pbwio__is_id(names[i]))) {
                column[dim++] = i;
            }
        }
    }
    if (dim < 2 || dim < o->dim) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%d coordinate%s where %d are needed", dim, dim == 1 ? "" : "s",
                    o->dim > 2 ? o->dim : 2);
    }
    dim = o->dim == 2 ? 2 : dim;
    column[3] = weight;
    r->cloud->dim = dim;
    for (k = 0, r->last_column = 0; k < 4; k++) {
        r->last_column = (k != 2 || dim == 3) && column[k] > r->last_column ? column[k] : r->last_column;
    }
    column[2] = column_count != 0 && column[2] >= column_count ? -1 : column[2];
    if (column_count != 0 && r->last_column >= column_count) {
        pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "column %d is needed, there are %d", r->last_column + 1,
                    column_count);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>points       Points of the cloud, from rows of fields.
   In: how many points are announced; the fields of a line.  Out: points, weights, heights, columns of the cloud.
   Holds: no more points than announced; no memory for more than the rest of the file has bytes for.
   ------------------------------------------------------------------------------------------------------ */

/* Room for the points of the rest of the file.  smallest: the fewest bytes that a point takes there; a file that
   announces more points than it has bytes for gets no memory for them. */
static void pbwio__reserve(pbwio__reader *r, unsigned long long announced, size_t smallest)
{
    size_t left = (size_t)(r->end - r->at), dim = (size_t)r->cloud->dim, count;
    if (r->status == PBWIO_OK && announced > (left + 1) / smallest) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%llu point%s announced, %zu byte%s", announced,
                    announced == 1 ? " is" : "s are", left, left == 1 ? " follows" : "s follow");
    }
    if (r->status == PBWIO_OK && announced >= PBW_NONE) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "more than %lu points", (unsigned long)PBW_NONE - 1);
    }
    if (r->status != PBWIO_OK || announced == 0) {
        return;
    }
    count = (size_t)announced;
    r->point_capacity = count;
    if (pbwio__fit_cloud(r, PBWIO__OF_ELEMENTS, &r->cloud->points, count, dim * sizeof(double))
        && r->column[3] >= 0) {
        (void)pbwio__fit_cloud(r, PBWIO__OF_WEIGHTS, &r->cloud->weights, count, sizeof(double));
    }
    if (dim == 2 && r->column[2] >= 0 && r->status == PBWIO_OK) {
        (void)pbwio__fit_cloud(r, PBWIO__OF_HEIGHTS, &r->cloud->heights, count, sizeof(double));
    }
}

/* What was taken for the height is missing or no number. */
static void pbwio__no_heights(pbwio__reader *r)
{
    pbwio__release(r, r->cloud->heights, r->cloud->capacity[PBWIO__OF_HEIGHTS], 1);
    r->cloud->heights = NULL;
    r->cloud->capacity[PBWIO__OF_HEIGHTS] = 0;
    r->column[2] = -1;
}

/* Where lines are not announced but counted, those that are too short to be points do not count. */
static size_t pbwio__most(const pbwio__reader *r, size_t lines)
{
    size_t most = ((size_t)(r->end - r->at) + 1) / (2 * (size_t)(r->last_column + 1));
    return lines < most ? lines : most;
}

static void pbwio__add_point(pbwio__reader *r, const double value[4])
{
    pbwio_cloud *cloud = r->cloud;
    size_t dim = (size_t)cloud->dim;
    if (cloud->count == r->point_capacity) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "more points than announced");
    }
    if (r->status == PBWIO_OK) {
        memcpy(cloud->points + cloud->count * dim, value, dim * sizeof(double));
        if (cloud->weights != NULL) {
            cloud->weights[cloud->count] = value[3];
        }
        if (cloud->heights != NULL) {
            cloud->heights[cloud->count] = value[2];
        }
        cloud->count++;
    }
}

/* Reads a point from the fields of the line that are left. */
static void pbwio__point(pbwio__reader *r)
{
    const int flat = r->cloud->dim == 2;
    double value[4];
    pbwio__field field;
    int i, k;
    r->marked.begin = r->marked.end = NULL;
    for (i = 0; i <= r->last_column || (flat && i <= r->column[2]) || i < r->marker; i++) {
        if (!pbwio__next(r, &field)) {
            if (i > r->last_column) {
                if (flat && i <= r->column[2]) {
                    pbwio__no_heights(r);
                }
                break;
            }
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "%d column%s where %d are needed", i, i == 1 ? "" : "s",
                        r->last_column + 1);
            return;
        }
        if (i < PBWIO__MOST_COLUMNS && r->kept[i] > 0 && r->cloud->count < r->point_capacity
            && !pbwio__decimal(field.begin, field.end, r->mark,
                               r->cloud->columns[r->kept[i] - 1].values + r->cloud->count)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "column %d, \"%s\", is kept and not a finite number", i + 1,
                        pbwio__show(r, field));
        }
        r->marked = i + 1 == r->marker ? field : r->marked;
        for (k = 0; k < 4; k++) {
            if (r->column[k] == i && !pbwio__decimal(field.begin, field.end, r->mark, &value[k])) {
                int comma;
                if (k == 2 && flat) {
                    pbwio__no_heights(r);
                    continue;
                }
                comma = r->mark == '.' && pbwio__decimal(field.begin, field.end, ',', &value[k]);
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "column %d, \"%s\", is not a finite number%s", i + 1,
                            pbwio__show(r, field), comma ? " (decimal commas are read on request)" : "");
            }
        }
    }
    pbwio__add_point(r, value);
}

/* ------------------------------------------------------------------------------------------------------
   >>elements     Elements and their groups; the end of a cloud.
   In: corners of elements, tags and names of groups.  Out: the elements and groups of the cloud; a cloud without
   them.  Holds: an array of groups, where there is one, has as much room as the array of its elements.
   ------------------------------------------------------------------------------------------------------ */

/* The groups of elements of a dimension, or of points; NULL: none is in a group. */
static pbw_index **pbwio__members(pbwio_cloud *cloud, int dim)
{
    return dim == 3 ? &cloud->tetrahedron_groups : dim == 2 ? &cloud->triangle_groups
         : dim == 1 ? &cloud->segment_groups : &cloud->point_groups;
}

/* The same from the first that is in one on: room for so many, `count` of which are filled. */
static int pbwio__group_room(pbwio__reader *r, int dim, size_t count, size_t capacity)
{
    pbw_index **groups = pbwio__members(r->cloud, dim);
    size_t i = *groups == NULL ? 0 : count;
    if (!pbwio__fit_cloud(r, PBWIO__OF_MEMBERS + dim, groups, capacity, sizeof **groups)) {
        return 0;
    }
    for (; i < capacity; i++) {
        (*groups)[i] = PBW_NONE;
    }
    return 1;
}

static void pbwio__free_members(pbwio__reader *r, int dim)
{
    pbw_index **groups = pbwio__members(r->cloud, dim);
    pbwio__release(r, *groups, r->cloud->capacity[PBWIO__OF_MEMBERS + dim], 1);
    *groups = NULL;
    r->cloud->capacity[PBWIO__OF_MEMBERS + dim] = 0;
}

#define PBWIO__OTHER_GROUPS "all groups but the first of points and elements that are in several"

/* Puts a point into the current group of points, unless it is in one. */
static void pbwio__group_point(pbwio__reader *r, size_t point)
{
    pbwio_cloud *cloud = r->cloud;
    if (r->group[0] == PBW_NONE || r->status != PBWIO_OK
        || (cloud->point_groups == NULL && !pbwio__group_room(r, 0, 0, r->point_capacity))) {
        return;
    }
    if (cloud->point_groups[point] == PBW_NONE) {
        cloud->point_groups[point] = r->group[0];
    } else if (cloud->point_groups[point] != r->group[0]) {
        pbwio__report_once(r, PBWIO__OTHER_GROUPS);
    }
}

/* Adds an element of dimension `dim`, 1 to 3, to the current group of that dimension. */
static void pbwio__add_simplex(pbwio__reader *r, int dim, const pbw_index *corner)
{
    pbwio_cloud *cloud = r->cloud;
    pbw_index **ids = dim == 3 ? &cloud->tetrahedra : dim == 2 ? &cloud->triangles : &cloud->segments;
    pbw_index **groups = pbwio__members(cloud, dim);
    size_t *count = dim == 3 ? &cloud->tetrahedron_count : dim == 2 ? &cloud->triangle_count : &cloud->segment_count;
    const size_t size = ((size_t)dim + 1) * sizeof(pbw_index);
    size_t capacity = cloud->capacity[PBWIO__OF_ELEMENTS + dim] / size;
    if (*count == capacity) {
        capacity += capacity / 2 + 64;
        if (!pbwio__fit_cloud(r, PBWIO__OF_ELEMENTS + dim, ids, capacity, size)
            || (*groups != NULL && !pbwio__group_room(r, dim, *count, capacity))) {
            return;
        }
    }
    if (r->group[dim] != PBW_NONE && *groups == NULL && !pbwio__group_room(r, dim, 0, capacity)) {
        return;
    }
    if (*groups != NULL) {
        (*groups)[*count] = r->group[dim];
    }
    memcpy(*ids + *count * ((size_t)dim + 1), corner, size);
    ++*count;
}

static void pbwio__add_triangle(pbwio__reader *r, size_t a, size_t b, size_t c)
{
    pbw_index corner[3];
    corner[0] = (pbw_index)a;
    corner[1] = (pbw_index)b;
    corner[2] = (pbw_index)c;
    pbwio__add_simplex(r, 2, corner);
}

static uint64_t pbwio__group_hash(int dim, long long tag, const char *name, size_t length)
{
    uint64_t h = (uint64_t)tag * 4 + (uint64_t)dim;
    size_t i;
    for (i = 0; i < length; i++) {
        h = (h ^ (unsigned char)name[i]) * 0x100000001b3u;           /* FNV-1a */
    }
    h *= 0x9e3779b97f4a7c15u;
    return h ^ h >> 32;
}

/* Doubles the table of groups. */
static int pbwio__group_table(pbwio__reader *r, int by_name)
{
    const pbwio_cloud *cloud = r->cloud;
    size_t size = r->group_table_size == 0 ? 64 : 2 * r->group_table_size, i, at;
    while (size < 2 * (cloud->group_count + 1)) {                    /* of a file that was read before this one */
        size *= 2;
    }
    if (!pbwio__fit(r, &r->group_table, &r->group_table_size, size, sizeof(pbw_index))) {
        return 0;
    }
    for (i = 0; i < size; i++) {
        r->group_table[i] = PBW_NONE;
    }
    for (i = 0; i < cloud->group_count; i++) {
        const pbwio_group *g = cloud->groups + i;
        const uint64_t h = by_name ? pbwio__group_hash(g->dim, 0, g->name, strlen(g->name))
                                   : pbwio__group_hash(g->dim, g->tag, "", 0);
        for (at = (size_t)h & (size - 1); r->group_table[at] != PBW_NONE; at = (at + 1) & (size - 1)) {
        }
        r->group_table[at] = (pbw_index)i;
    }
    return 1;
}

/* The index of the group of that dimension and tag, or, if there is a name and the tag is 0, of that dimension and
   name; new if there is none.  A file finds all of its groups by tags, or all by names.  PBW_NONE: it has failed. */
static pbw_index pbwio__find_group(pbwio__reader *r, int dim, long long tag, const char *name, size_t length)
{
    pbwio_cloud *cloud = r->cloud;
    const int by_name = tag == 0 && length > 0;
    const uint64_t h = pbwio__group_hash(dim, tag, name, by_name ? length : 0);
    pbwio_group *g;
    size_t at;
    if (2 * (cloud->group_count + 1) > r->group_table_size && !pbwio__group_table(r, by_name)) {
        return PBW_NONE;
    }
    for (at = (size_t)h & (r->group_table_size - 1); r->group_table[at] != PBW_NONE;
         at = (at + 1) & (r->group_table_size - 1)) {
        g = cloud->groups + r->group_table[at];
        if (g->dim == dim && (by_name ? strlen(g->name) == length && memcmp(g->name, name, length) == 0
                                      : g->tag == tag)) {
            return r->group_table[at];
        }
    }
    if (cloud->group_count == cloud->capacity[PBWIO__OF_GROUPS] / sizeof *g
        && !pbwio__fit_cloud(r, PBWIO__OF_GROUPS, &cloud->groups, cloud->group_count + cloud->group_count / 2 + 16,
                             sizeof *g)) {
        return PBW_NONE;
    }
    g = cloud->groups + cloud->group_count;
    g->dim = dim;
    g->tag = by_name ? (long long)cloud->group_count + 1 : tag;
    g->name = length > 0 ? pbwio__copy(r, name, length) : NULL;
    if (length > 0 && g->name == NULL) {
        return PBW_NONE;
    }
    r->group_table[at] = (pbw_index)cloud->group_count;
    return (pbw_index)cloud->group_count++;
}

/* Records that the last triangle is of a polygon of that many corners, four or more. */
static void pbwio__record_polygon(pbwio__reader *r, size_t corners)
{
    if (corners == 4) {
        const size_t first = r->cloud->triangle_count - 2;
        pbwio__polygon polygon;
        polygon.first = (pbw_index)first;
        polygon.corners = 4;
        if (first >= PBW_NONE) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "more than %lu triangles", (unsigned long)PBW_NONE - 1);
        }
        if (!PBWIO__PUSH(r, r->polygons, polygon)) {
            return;
        }
    }
    r->polygons.at[r->polygons.count - 1].corners = (pbw_index)corners;
}

/* No element and no point is in a group. */
static void pbwio__clear_groups(pbwio__reader *r)
{
    pbwio_cloud *cloud = r->cloud;
    size_t i;
    int dim;
    for (i = 0; i < cloud->group_count; i++) {
        char *name = cloud->groups[i].name;
        pbwio__release(r, name, name != NULL ? strlen(name) + 1 : 0, 1);
    }
    cloud->group_count = 0;
    for (i = 0; i < r->group_table_size; i++) {
        r->group_table[i] = PBW_NONE;
    }
    for (dim = 0; dim < 4; dim++) {
        pbw_index *groups = *pbwio__members(cloud, dim);
        r->group[dim] = PBW_NONE;
        for (i = 0; groups != NULL && i < cloud->capacity[PBWIO__OF_MEMBERS + dim] / sizeof *groups; i++) {
            groups[i] = PBW_NONE;
        }
    }
}

/* The k-th corner of a polygon; from the third on each makes a triangle. */
static void pbwio__add_corner(pbwio__reader *r, double id, long long point_count, long long k)
{
    if (!(id >= 0 && id < (double)point_count && id == floor(id))) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "a face has point %.17g, there are %lld (from 0)", id, point_count);
        return;
    }
    if (k >= 2) {
        pbwio__add_triangle(r, r->fan[0], r->fan[1], (size_t)id);
    }
    if (k >= 3 && r->status == PBWIO_OK) {
        pbwio__record_polygon(r, (size_t)k + 1);
    }
    r->fan[k > 0] = (size_t)id;
}

/* Resizes all arrays of a cloud to what they hold, or frees them; columns and groups keep their room.  An array that
   cannot shrink is fine as it is. */
static void pbwio__trim_arrays(pbwio_cloud *cloud, int free_all)
{
    const size_t n = cloud->count * sizeof(double), id = sizeof(pbw_index);
    const struct { void *array; size_t bytes; } arrays[] = {
        { &cloud->points, n * (size_t)cloud->dim }, { &cloud->segments, 2 * id * cloud->segment_count },
        { &cloud->triangles, 3 * id * cloud->triangle_count },
        { &cloud->tetrahedra, 4 * id * cloud->tetrahedron_count },
        { &cloud->point_groups, id * cloud->count }, { &cloud->segment_groups, id * cloud->segment_count },
        { &cloud->triangle_groups, id * cloud->triangle_count },
        { &cloud->tetrahedron_groups, id * cloud->tetrahedron_count }, { &cloud->weights, n }, { &cloud->heights, n },
        { &cloud->groups, cloud->capacity[PBWIO__OF_GROUPS] },
        { &cloud->columns, cloud->capacity[PBWIO__OF_COLUMNS] },
        { &cloud->seeds, cloud->seed_count * sizeof(pbwio_seed) }
    };
    size_t i;
    for (i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
        void *block;
        memcpy(&block, arrays[i].array, sizeof block);
        if (block != NULL && (free_all || arrays[i].bytes == 0)) {
            (void)pbw_memory_resize(&cloud->memory, block, cloud->capacity[i], 0, 1);
            block = NULL;
            memcpy(arrays[i].array, &block, sizeof block);
            cloud->capacity[i] = 0;
        } else if (block != NULL) {
            (void)pbw_memory_fit(&cloud->memory, arrays[i].array, cloud->capacity + i, arrays[i].bytes, 1);
        }
    }
}

PBWDEF void pbwio_free(pbwio_cloud *cloud)
{
    size_t i;
    if (cloud != NULL) {
        pbw_memory *memory = &cloud->memory;
        if (memory->resize == NULL) {                                /* it was made otherwise than by reading */
            pbw_memory_start(memory, NULL);
        }
        for (i = 0; i < cloud->group_count; i++) {
            char *name = cloud->groups[i].name;
            (void)pbw_memory_resize(memory, name, name != NULL ? strlen(name) + 1 : 0, 0, 1);
        }
        for (i = 0; i < cloud->column_count; i++) {
            char *name = cloud->columns[i].name;
            double *values = cloud->columns[i].values;
            (void)pbw_memory_resize(memory, name, name != NULL ? strlen(name) + 1 : 0, 0, 1);
            (void)pbw_memory_resize(memory, values, values != NULL ? cloud->capacity[PBWIO__OF_VALUES] : 0, 0, 1);
        }
        pbwio__trim_arrays(cloud, 1);
        memset(cloud, 0, sizeof *cloud);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>polygons     Triangles inside the outline of a polygon.
   In: polygons of more than three corners, each as a fan of triangles about its first corner; all points.
   Out: the same number of triangles in the same places, inside the outline.
   Holds: signs are exact; n corners take O(n log n) steps.

   1. The polygon is projected along the axis in which its area vector is largest.  A fan that lies inside stays.
   2. Else a line sweeps over the corners, ordered by x and then by y.  The parts of the line inside the polygon are
      intervals, each between a lower and an upper edge.
   3. To the left of an interval all is triangulated up to a chain of corners, from the left end of its lower edge to
      that of its upper edge.  The next corner takes the triangles that it sees there (Hertel and Mehlhorn 1983, "Fast
      triangulation of simple polygons").
   4. Edges that become neighbours are tested against each other, so that an outline that crosses or touches itself is
      found (Shamos and Hoey 1976, "Geometric intersection problems").
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwio__node { pbw_index corner, next[2]; } pbwio__node;      /* of a chain; next: lower, upper */

typedef struct pbwio__interval {
    pbw_index edge[2];                       /* lower, upper; edge i goes from corner i to the next one */
    pbw_index end[2], last;                  /* nodes of the chain: its lower and its upper end, its rightmost */
    pbw_index nearby[2];                     /* the intervals below and above */
    pbw_index child[2], parent;              /* in a splay tree, from below to above */
} pbwio__interval;

typedef struct pbwio__sweep {
    size_t n;
    const pbw_index *id;                     /* the points of the corners */
    double *xy;                              /* counter-clockwise if the polygon is simple */
    pbw_index *order, *interval_of;          /* corners from left to right; the interval of an edge */
    pbwio__node *nodes;
    pbwio__interval *intervals;
    pbw_index node_count, interval_count, root;
    pbw_index *triangles;
    size_t triangle_count;
    int failed;                              /* the polygon is not simple */
} pbwio__sweep;

static pbw_index pbwio__after(const pbwio__sweep *s, pbw_index i)
{
    return i + 1 < s->n ? i + 1 : 0;
}

static pbw_index pbwio__before(const pbwio__sweep *s, pbw_index i)
{
    return i > 0 ? i - 1 : (pbw_index)s->n - 1;
}

/* Whether corner a is left of corner b, or below it where x is the same. */
static int pbwio__left_of(const double *xy, pbw_index a, pbw_index b)
{
    const double *p = xy + 2 * (size_t)a, *q = xy + 2 * (size_t)b;
    return p[0] < q[0] || (!(p[0] > q[0]) && p[1] < q[1]);
}

static int pbwio__turn(const pbwio__sweep *s, pbw_index a, pbw_index b, pbw_index c)
{
    return pbw_orient2(s->xy + 2 * (size_t)a, s->xy + 2 * (size_t)b, s->xy + 2 * (size_t)c);
}

/* Sorts corners from left to right by merging runs; spare: room for n more. */
static void pbwio__sort_corners(const double *xy, pbw_index *order, pbw_index *spare, size_t n)
{
    size_t width, from, i, j, k, middle, end;
    for (i = 0; i < n; i++) {
        order[i] = (pbw_index)i;
    }
    for (width = 1; width < n; width *= 2) {
        for (from = 0; from < n; from = end) {
            middle = from + width < n ? from + width : n;
            end = middle + width < n ? middle + width : n;
            for (i = k = from, j = middle; k < end; k++) {
                spare[k] = i < middle && (j == end || !pbwio__left_of(xy, order[j], order[i])) ? order[i++]
                         : order[j++];
            }
        }
        memcpy(order, spare, n * sizeof *order);
    }
}

/* ---- the tree of intervals ---- */

static void pbwio__rotate(pbwio__interval *all, pbw_index x)
{
    const pbw_index p = all[x].parent, g = all[p].parent;
    const int side = all[p].child[1] == x;
    const pbw_index inner = all[x].child[!side];
    all[p].child[side] = inner;
    if (inner != PBW_NONE) {
        all[inner].parent = p;
    }
    all[x].child[!side] = p;
    all[p].parent = x;
    all[x].parent = g;
    if (g != PBW_NONE) {
        all[g].child[all[g].child[1] == p] = x;
    }
}

/* Makes an interval the root (Sleator and Tarjan 1985, "Self-adjusting binary search trees"). */
static void pbwio__splay(pbwio__sweep *s, pbw_index x)
{
    pbwio__interval *all = s->intervals;
    while (all[x].parent != PBW_NONE) {
        const pbw_index p = all[x].parent, g = all[p].parent;
        if (g != PBW_NONE) {
            pbwio__rotate(all, (all[p].child[1] == x) == (all[g].child[1] == p) ? p : x);
        }
        pbwio__rotate(all, x);
    }
    s->root = x;
}

/* Adds an interval above that one, or below all others. */
static pbw_index pbwio__add_interval(pbwio__sweep *s, pbw_index below)
{
    const pbw_index x = s->interval_count++;
    pbwio__interval *all = s->intervals, *interval = all + x;
    pbw_index upper = s->root;
    memset(interval, 0xff, sizeof *interval);                      /* PBW_NONE everywhere */
    if (below != PBW_NONE) {
        pbwio__splay(s, below);
        upper = all[below].child[1];
        all[below].child[1] = PBW_NONE;
        all[below].parent = x;
        interval->nearby[1] = all[below].nearby[1];
        all[below].nearby[1] = x;
    } else {
        pbw_index lowest = s->root;
        while (lowest != PBW_NONE && all[lowest].nearby[0] != PBW_NONE) {
            lowest = all[lowest].nearby[0];
        }
        interval->nearby[1] = lowest;
    }
    interval->nearby[0] = interval->child[0] = below;
    interval->child[1] = upper;
    if (upper != PBW_NONE) {
        all[upper].parent = x;
    }
    if (interval->nearby[1] != PBW_NONE) {
        all[interval->nearby[1]].nearby[0] = x;
    }
    s->root = x;
    return x;
}

static void pbwio__remove_interval(pbwio__sweep *s, pbw_index x)
{
    pbwio__interval *all = s->intervals;
    const pbw_index below = all[x].nearby[0], above = all[x].nearby[1];
    pbw_index lower, upper;
    pbwio__splay(s, x);
    lower = all[x].child[0];
    upper = all[x].child[1];
    s->root = upper;
    if (lower != PBW_NONE) {
        all[lower].parent = PBW_NONE;
        pbwio__splay(s, below);
        all[below].child[1] = upper;
        all[below].nearby[1] = above;
    }
    if (upper != PBW_NONE) {
        all[upper].parent = below;
        all[above].nearby[0] = below;
    }
}

/* The highest interval with a lower edge below corner v; PBW_NONE: there is none. */
static pbw_index pbwio__interval_below(pbwio__sweep *s, pbw_index v)
{
    pbw_index at = s->root, found = PBW_NONE, deepest = PBW_NONE;
    while (at != PBW_NONE && !s->failed) {
        const pbw_index edge = s->intervals[at].edge[0];
        const int side = pbwio__turn(s, edge, pbwio__after(s, edge), v);
        s->failed |= side == 0;
        deepest = at;
        found = side > 0 ? at : found;
        at = s->intervals[at].child[side > 0];
    }
    if (deepest != PBW_NONE) {
        pbwio__splay(s, deepest);                                    /* pays for the search */
    }
    return found;
}

/* ---- edges and chains ---- */

/* Edges that are neighbours on the line must not have a point in common but a corner at an end. */
static void pbwio__test_edges(pbwio__sweep *s, pbw_index e, pbw_index f)
{
    const pbw_index a = e, b = pbwio__after(s, e), c = f, d = pbwio__after(s, f);
    if (b == c || d == a) {
        s->failed |= pbwio__turn(s, a, b, b == c ? d : c) == 0;
    } else {
        s->failed |= pbwio__turn(s, a, b, c) * pbwio__turn(s, a, b, d) <= 0
                  && pbwio__turn(s, c, d, a) * pbwio__turn(s, c, d, b) <= 0;
    }
}

/* Tests the lower (0) or the upper (1) edge of an interval against both of its neighbours. */
static void pbwio__test_interval(pbwio__sweep *s, pbw_index interval, int side)
{
    const pbwio__interval *p = s->intervals + interval;
    pbwio__test_edges(s, p->edge[0], p->edge[1]);
    if (p->nearby[side] != PBW_NONE) {
        pbwio__test_edges(s, p->edge[side], s->intervals[p->nearby[side]].edge[!side]);
    }
}

static pbw_index pbwio__add_node(pbwio__sweep *s, pbw_index corner)
{
    pbwio__node *node = s->nodes + s->node_count;
    node->corner = corner;
    node->next[0] = node->next[1] = PBW_NONE;
    return s->node_count++;
}

/* From a node on, down (0) or up (1) along its chain, adds the triangles that corner v sees.  Returns the node
   where they end. */
static pbw_index pbwio__add_visible(pbwio__sweep *s, pbw_index at, int side, pbw_index v)
{
    pbw_index next;
    for (; (next = s->nodes[at].next[side]) != PBW_NONE; at = next) {
        const pbw_index low = s->nodes[side ? at : next].corner, high = s->nodes[side ? next : at].corner;
        if (pbwio__turn(s, low, v, high) <= 0 || s->triangle_count == s->n - 2) {
            break;
        }
        s->triangles[3 * s->triangle_count] = s->id[low];
        s->triangles[3 * s->triangle_count + 1] = s->id[v];
        s->triangles[3 * s->triangle_count++ + 2] = s->id[high];
    }
    return at;
}

static void pbwio__link(pbwio__sweep *s, pbw_index lower, pbw_index upper)
{
    s->nodes[lower].next[1] = upper;
    s->nodes[upper].next[0] = lower;
}

/* ---- the corners that the line meets ---- */

/* Both edges of v go to the right: an interval starts, or the interval that v lies in becomes two. */
static void pbwio__start_interval(pbwio__sweep *s, pbw_index v)
{
    const pbw_index before = pbwio__before(s, v), found = pbwio__interval_below(s, v);
    const int turn = pbwio__turn(s, before, v, pbwio__after(s, v));
    pbw_index interval, last, lower, upper, low, high;
    pbwio__interval *p;
    int inside = 0;
    if (found != PBW_NONE) {
        const pbw_index edge = s->intervals[found].edge[1];
        const int side = pbwio__turn(s, edge, pbwio__after(s, edge), v);
        s->failed |= side == 0;
        inside = side > 0;
    }
    s->failed |= turn == 0 || inside != (turn < 0);
    if (s->failed) {
        return;
    }
    interval = pbwio__add_interval(s, found);
    p = s->intervals + interval;
    p->edge[0] = v;
    p->edge[1] = before;
    p->end[0] = p->end[1] = p->last = low = high = pbwio__add_node(s, v);
    if (inside) {
        last = s->intervals[found].last;
        lower = pbwio__add_visible(s, last, 0, v);
        upper = pbwio__add_visible(s, last, 1, v);
        high = pbwio__add_node(s, v);
        p->end[1] = s->intervals[found].end[1];
        if (lower == upper) {                                        /* the corner is in both chains */
            upper = pbwio__add_node(s, s->nodes[last].corner);
            if (s->nodes[last].next[1] != PBW_NONE) {
                pbwio__link(s, upper, s->nodes[last].next[1]);
            }
            p->end[1] = p->end[1] == last ? upper : p->end[1];
        }
        pbwio__link(s, low, upper);
        pbwio__link(s, lower, high);
        p->edge[1] = s->intervals[found].edge[1];
        s->intervals[found].edge[1] = before;
        s->intervals[found].end[1] = s->intervals[found].last = high;
        pbwio__test_interval(s, found, 1);
    }
    s->interval_of[before] = inside ? found : interval;
    s->interval_of[v] = interval;
    s->interval_of[p->edge[1]] = inside ? interval : s->interval_of[p->edge[1]];
    pbwio__test_interval(s, interval, 0);
    pbwio__test_interval(s, interval, 1);
}

/* Edge `old` of an interval ends in v; edge `next` starts there and takes its place. */
static void pbwio__continue_interval(pbwio__sweep *s, pbw_index v, pbw_index old, pbw_index next)
{
    const pbw_index interval = s->interval_of[old], node = pbwio__add_node(s, v);
    pbwio__interval *p = s->intervals + interval;
    const int side = p->edge[1] == old;
    const pbw_index end = pbwio__add_visible(s, p->end[side], !side, v);
    pbwio__link(s, side ? end : node, side ? node : end);
    p->end[side] = p->last = node;
    p->edge[side] = next;
    s->interval_of[next] = interval;
    pbwio__test_interval(s, interval, side);
}

/* Both edges of v come from the left: an interval ends, or two become one. */
static void pbwio__end_interval(pbwio__sweep *s, pbw_index v)
{
    const pbw_index upper = s->interval_of[pbwio__before(s, v)], lower = s->interval_of[v];
    pbwio__interval *p = s->intervals + lower, *q = s->intervals + upper;
    pbw_index node, low, high;
    if (lower == upper) {
        s->failed |= pbwio__add_visible(s, p->end[0], 1, v) != p->end[1];
        low = p->nearby[0];
        high = p->nearby[1];
        pbwio__remove_interval(s, lower);
        if (low != PBW_NONE && high != PBW_NONE) {
            pbwio__test_edges(s, s->intervals[low].edge[1], s->intervals[high].edge[0]);
        }
        return;
    }
    s->failed |= p->nearby[1] != upper;
    if (s->failed) {
        return;
    }
    node = pbwio__add_node(s, v);
    low = pbwio__add_visible(s, p->end[1], 0, v);
    high = pbwio__add_visible(s, q->end[0], 1, v);
    pbwio__link(s, low, node);
    pbwio__link(s, node, high);
    p->end[1] = q->end[1];
    p->edge[1] = q->edge[1];
    p->last = node;
    s->interval_of[p->edge[1]] = lower;
    pbwio__remove_interval(s, upper);
    pbwio__test_interval(s, lower, 1);
}

/* Triangulates the polygon of s->xy; returns whether it is simple. */
static int pbwio__sweep_polygon(pbwio__sweep *s)
{
    const size_t n = s->n;
    pbw_index i, v, before, after;
    s->node_count = s->interval_count = 0;
    s->root = PBW_NONE;
    s->triangle_count = 0;
    pbwio__sort_corners(s->xy, s->order, (pbw_index *)(void *)s->nodes, n);
    v = s->order[0];
    s->failed = pbwio__turn(s, pbwio__before(s, v), v, pbwio__after(s, v)) == 0;
    if (pbwio__turn(s, pbwio__before(s, v), v, pbwio__after(s, v)) < 0) {    /* x and y change places */
        for (i = 0; i < n; i++) {
            const double x = s->xy[2 * (size_t)i];
            s->xy[2 * (size_t)i] = s->xy[2 * (size_t)i + 1];
            s->xy[2 * (size_t)i + 1] = x;
        }
        pbwio__sort_corners(s->xy, s->order, (pbw_index *)(void *)s->nodes, n);
    }
    for (i = 1; i < n; i++) {
        s->failed |= !pbwio__left_of(s->xy, s->order[i - 1], s->order[i]);   /* one place twice */
    }
    for (i = 0; i < n && !s->failed; i++) {
        v = s->order[i];
        before = pbwio__before(s, v);
        after = pbwio__after(s, v);
        if (pbwio__left_of(s->xy, before, v)) {
            if (pbwio__left_of(s->xy, after, v)) {
                pbwio__end_interval(s, v);
            } else {
                pbwio__continue_interval(s, v, before, v);
            }
        } else if (pbwio__left_of(s->xy, after, v)) {
            pbwio__continue_interval(s, v, v, before);
        } else {
            pbwio__start_interval(s, v);
        }
    }
    return !s->failed && s->triangle_count == n - 2;
}

/* ---- a polygon of the file ---- */

/* The axes of the projection for each attempt, from the largest component of the area vector to the smallest.
   Returns how many attempts there are. */
static int pbwio__axes(const pbwio_cloud *cloud, const pbw_index *fan, size_t n, int axes[3][2])
{
    const double *p = cloud->points, *o = p + 3 * (size_t)fan[0];
    double area[3] = { 0, 0, 0 }, scale = 0, a[3], b[3];
    size_t i;
    int k, m, swap;
    axes[0][0] = 0;
    axes[0][1] = 1;
    if (cloud->dim == 2) {
        return 1;
    }
    for (i = 0; i < 3 * (n - 2); i++) {
        for (k = 0; k < 3; k++) {
            scale = fmax(scale, fabs(p[3 * (size_t)fan[i] + (size_t)k]));
        }
    }
    scale = scale > 0 ? 0.25 / scale : 1;                            /* keeps products in range */
    scale = scale <= DBL_MAX ? scale : DBL_MAX;
    for (i = 0; i < n - 2; i++) {
        for (k = 0; k < 3; k++) {
            a[k] = p[3 * (size_t)fan[3 * i + 1] + (size_t)k] * scale - o[k] * scale;
            b[k] = p[3 * (size_t)fan[3 * i + 2] + (size_t)k] * scale - o[k] * scale;
        }
        for (k = 0; k < 3; k++) {
            area[k] += a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        }
    }
    for (k = 0; k < 3; k++) {
        axes[k][0] = k;                                              /* the axis to look along, for now */
        for (m = k; m > 0 && fabs(area[axes[m][0]]) > fabs(area[axes[m - 1][0]]); m--) {
            swap = axes[m][0];
            axes[m][0] = axes[m - 1][0];
            axes[m - 1][0] = swap;
        }
    }
    for (k = 0; k < 3; k++) {
        axes[k][1] = (axes[k][0] + 2) % 3;
        axes[k][0] = (axes[k][0] + 1) % 3;
    }
    return 3;
}

/* Whether a fan lies inside its polygon and fills it: its triangles turn the same way, once around at most. */
static int pbwio__fan_fits(const pbwio_cloud *cloud, const pbw_index *fan, size_t n, const int axis[2])
{
    const size_t dim = (size_t)cloud->dim;
    double corner[4][2];
    size_t i;
    int k, turn, first = 0, behind = 0;
    for (i = 0; i < n - 2; i++) {
        for (k = 0; k < 2; k++) {
            corner[0][k] = cloud->points[dim * fan[0] + (size_t)axis[k]];
            corner[1][k] = cloud->points[dim * fan[1] + (size_t)axis[k]];
            corner[2][k] = cloud->points[dim * fan[3 * i + 1] + (size_t)axis[k]];
            corner[3][k] = cloud->points[dim * fan[3 * i + 2] + (size_t)axis[k]];
        }
        turn = pbw_orient2(corner[0], corner[2], corner[3]);
        first = i == 0 ? turn : first;
        if (turn == 0 || turn != first) {
            return 0;
        }
        if (i > 0) {                                                 /* the side of the first ray */
            turn = pbw_orient2(corner[0], corner[1], corner[3]);
            if (behind && turn != -first) {
                return 0;
            }
            behind |= turn != first;
        }
    }
    return 1;
}

/* Cuts the polygon of n corners with a fan that does not fit; returns whether it is simple. */
static int pbwio__cut_polygon(pbwio__reader *r, pbw_index *fan, size_t n, int axes[3][2], int tries)
{
    const size_t dim = (size_t)r->cloud->dim, intervals = n / 2 + 1;
    const size_t size = n * (2 * sizeof(double) + 3 * sizeof(pbw_index) + 2 * sizeof(pbwio__node))
                      + intervals * sizeof(pbwio__interval);
    char *block = (char *)pbwio__resize(r, NULL, 0, size, 1);
    pbwio__sweep s;
    pbw_index *id;
    size_t i;
    int t, k, done = 0;
    if (block == NULL) {
        return 0;
    }
    memset(&s, 0, sizeof s);
    s.n = n;
    s.xy = (double *)(void *)block;
    s.nodes = (pbwio__node *)(void *)(s.xy + 2 * n);
    s.intervals = (pbwio__interval *)(void *)(s.nodes + 2 * n);
    s.order = (pbw_index *)(void *)(s.intervals + intervals);
    s.interval_of = s.order + n;
    id = s.interval_of + n;
    s.id = id;
    s.triangles = fan;
    for (i = 0; i < n; i++) {
        id[i] = i < 2 ? fan[i] : fan[3 * (i - 2) + 2];
    }
    for (t = 0; t < tries && !done; t++) {
        for (i = 0; i < 2 * n; i++) {
            s.xy[i] = r->cloud->points[dim * id[i / 2] + (size_t)axes[t][i % 2]];
        }
        done = pbwio__sweep_polygon(&s);
    }
    for (i = 0; i < n - 2 && !done; i++) {                           /* the fan again */
        for (k = 0; k < 3; k++) {
            fan[3 * i + (size_t)k] = id[k == 0 ? 0 : i + (size_t)k];
        }
    }
    pbwio__release(r, block, size, 1);
    return done;
}

/* Puts triangles inside the outlines of all polygons. */
static void pbwio__cut_polygons(pbwio__reader *r)
{
    size_t i, bad = 0;
    int axes[3][2], tries;
    for (i = 0; i < r->polygons.count && r->status == PBWIO_OK; i++) {
        const size_t n = r->polygons.at[i].corners;
        pbw_index *fan = r->cloud->triangles + 3 * r->polygons.at[i].first;
        if (i % 1024 == 0 && pbwio__stops(r->options->build, 1)) {
            pbwio__fail(r, PBWIO_CANCELLED, "cancelled");
        }
        tries = pbwio__axes(r->cloud, fan, n, axes);
        if (!pbwio__fan_fits(r->cloud, fan, n, axes[0]) && !pbwio__cut_polygon(r, fan, n, axes, tries)) {
            bad++;
        }
    }
    if (bad > 0 && r->status == PBWIO_OK) {
        pbwio__report_dropped(r, "outlines of %zu polygon%s: flat, or they cross or touch themselves (fans instead)",
                              bad, bad == 1 ? "" : "s");
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>facets       Triangles of a facet with several outlines, holes, lines and points.
   In: points of the cloud, in outlines of any number of corners; points in holes.  Out: triangles of the cloud, and
   segments: edges of outlines with triangles, or none, on both sides.
   Holds: links of triangles agree; signs are exact; n corners and edges that cross m triangles take O(n log n + m).

   1. The facet is projected along the axis in which a large triangle of its corners is largest.  A line sweeps over
      the points: each is joined to the edges of the hull that it sees.
   2. Edges of outlines are inserted one by one.  The triangles that an edge crosses leave a hole on each of its
      sides, of which all is seen from the edge: Graham's scan fills such a hole (Toussaint and Avis 1982, "On a
      convex hull algorithm for polygons and its application to triangulation problems").
   3. What the outside or a hole reaches without crossing an edge is taken away.  Points in holes are vertices until
      then.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwio__flat { pbw_index v[3], link[3]; unsigned char wall[3], out; } pbwio__flat;
typedef struct pbwio__chained {              /* a vertex, and what is beyond the edge from the one before */
    pbw_index vertex, code;
    int wall, is_hinge;                      /* code: then the number of the hinge */
} pbwio__chained;
typedef struct pbwio__facet {
    pbwio__reader *r;
    PBW_ARRAY(pbw_index) corners, ends;      /* of the outlines: points; where each outline ends */
    PBW_ARRAY(double) holes;                 /* 3 coordinates each */
    PBW_ARRAY(pbw_index) local;              /* of each point of the cloud: its number here, or PBW_NONE */
    PBW_ARRAY(pbw_index) id;                 /* the other way round; PBW_NONE: in a hole */
    PBW_ARRAY(double) xy;
    PBW_ARRAY(pbw_index) order, next, before, edge, degree;      /* of the hull: next, before, the code of the edge
                                                                    to the next; edge becomes a code at each point */
    PBW_ARRAY(pbwio__flat) triangles;        /* counter-clockwise; code 4 t + k: the edge across from corner k */
    PBW_ARRAY(pbwio__chained) chains[2], stack; /* right and left of an edge that is inserted */
    PBW_ARRAY(pbw_index) unused, hinges;     /* hinges: the code of the side that is made first */
    size_t bent;                             /* facets that are not flat, and how far from it they are */
    double bend;
} pbwio__facet;

#define PBWIO__ROOM(r, a, n) ((n) <= (a).capacity || pbwio__fit(r, &(a).at, &(a).capacity, n, sizeof *(a).at))

static void pbwio__release_facet(pbwio__facet *f)
{
    PBWIO__RELEASE(f->r, f->corners);
    PBWIO__RELEASE(f->r, f->ends);
    PBWIO__RELEASE(f->r, f->holes);
    PBWIO__RELEASE(f->r, f->local);
    PBWIO__RELEASE(f->r, f->id);
    PBWIO__RELEASE(f->r, f->xy);
    PBWIO__RELEASE(f->r, f->order);
    PBWIO__RELEASE(f->r, f->next);
    PBWIO__RELEASE(f->r, f->before);
    PBWIO__RELEASE(f->r, f->edge);
    PBWIO__RELEASE(f->r, f->degree);
    PBWIO__RELEASE(f->r, f->triangles);
    PBWIO__RELEASE(f->r, f->chains[0]);
    PBWIO__RELEASE(f->r, f->chains[1]);
    PBWIO__RELEASE(f->r, f->stack);
    PBWIO__RELEASE(f->r, f->unused);
    PBWIO__RELEASE(f->r, f->hinges);
}

static int pbwio__turn_of(const pbwio__facet *f, pbw_index a, pbw_index b, pbw_index c)
{
    const double *xy = f->xy.at;
    return pbw_orient2(xy + 2 * (size_t)a, xy + 2 * (size_t)b, xy + 2 * (size_t)c);
}

/* ---- the projection ---- */

/* Finds two axes to project on, by corners far from each other.  Counts the facet if it is not flat. */
static void pbwio__project(pbwio__facet *f, int axis[2])
{
    const double *points = f->r->cloud->points, *p[3];
    double largest = 0, scale = 0, normal[3] = { 0, 0, 1 };
    size_t i;
    int k, pass;
    unsigned bent = 0;
    p[0] = p[1] = p[2] = points + 3 * (size_t)f->corners.at[0];
    for (i = 0; i < 3 * f->corners.count; i++) {
        scale = fmax(scale, fabs(points[3 * (size_t)f->corners.at[i / 3] + i % 3]));
    }
    scale = scale > 0 ? fmin(0.25 / scale, DBL_MAX) : 1;             /* keeps products in range */
    for (pass = 0; pass < 2; pass++, largest = 0) {
        for (i = 0; i < f->corners.count; i++) {
            const double *q = points + 3 * (size_t)f->corners.at[i];
            double a[3], b[3], n[3], size = 0;
            for (k = 0; k < 3; k++) {
                a[k] = p[1][k] * scale - p[0][k] * scale;
                b[k] = q[k] * scale - p[0][k] * scale;
            }
            for (k = 0; k < 3; k++) {
                n[k] = pass == 0 ? b[k] : a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
                size = fmax(size, fabs(n[k]));
            }
            if (size > largest) {
                largest = size;
                p[1 + pass] = q;
                memcpy(normal, n, sizeof n);
            }
        }
        if (pass == 1 && !(largest > 0)) {                           /* on one line: normal is its direction */
            k = fabs(normal[0]) < fabs(normal[1]) ? 0 : 1;
            k = fabs(normal[2]) < fabs(normal[k]) ? 2 : k;
            normal[0] = normal[1] = normal[2] = 0;
            normal[k] = 1;
        }
    }
    k = fabs(normal[0]) > fabs(normal[1]) ? 0 : 1;
    k = fabs(normal[2]) > fabs(normal[k]) ? 2 : k;
    axis[0] = (k + 1) % 3;
    axis[1] = (k + 2) % 3;
    for (i = 0; i < f->corners.count; i++) {
        const double *q = points + 3 * (size_t)f->corners.at[i];
        if (pbw_orient3(p[0], p[1], p[2], q) != 0) {
            double along = 0;
            for (k = 0; k < 3; k++) {
                along += normal[k] * (q[k] * scale - p[0][k] * scale);
            }
            f->bend = fmax(f->bend, fabs(along) / scale / sqrt(normal[0] * normal[0] + normal[1] * normal[1]
                                                               + normal[2] * normal[2]));
            bent = 1;
        }
    }
    f->bent += bent;
}

/* Gives the corners and the points in holes numbers and places in the plane; `order` has those that differ, from left
   to right.  Returns 0 where points of different places fall together. */
static int pbwio__place_corners(pbwio__facet *f, const int axis[2])
{
    pbwio__reader *r = f->r;
    size_t i, k, n, kept = 0;
    f->id.count = 0;
    for (i = 0; i < f->corners.count; i++) {
        pbw_index *local = f->local.at + f->corners.at[i];
        if (*local == PBW_NONE) {
            *local = (pbw_index)f->id.count;
            if (!PBWIO__PUSH(r, f->id, f->corners.at[i])) {
                return 1;
            }
        }
    }
    n = f->id.count + f->holes.count / 3;
    if (!PBWIO__ROOM(r, f->id, n) || !PBWIO__ROOM(r, f->xy, 2 * n) || !PBWIO__ROOM(r, f->order, n)
        || !PBWIO__ROOM(r, f->next, n) || !PBWIO__ROOM(r, f->before, n) || !PBWIO__ROOM(r, f->edge, n)
        || !PBWIO__ROOM(r, f->degree, n) || !PBWIO__ROOM(r, f->triangles, 2 * n)) {
        return 1;
    }
    for (i = 0; i < n; i++) {
        const double *p = i < f->id.count ? r->cloud->points + 3 * (size_t)f->id.at[i]
                        : f->holes.at + 3 * (i - f->id.count);
        for (k = 0; k < 2; k++) {
            f->xy.at[2 * i + k] = p[axis[k]];
        }
        f->degree.at[i] = 0;
    }
    for (; f->id.count < n; f->id.count++) {
        f->id.at[f->id.count] = PBW_NONE;
    }
    pbwio__sort_corners(f->xy.at, f->order.at, f->next.at, n);
    for (i = 0; i < n; i++) {
        const pbw_index p = f->order.at[i], q = f->order.at[kept > 0 ? kept - 1 : 0];
        if (kept == 0 || pbwio__left_of(f->xy.at, q, p)) {
            f->order.at[kept++] = p;
        } else if (f->id.at[p] == PBW_NONE || f->id.at[q] == PBW_NONE
                   || memcmp(r->cloud->points + 3 * (size_t)f->id.at[p], r->cloud->points + 3 * (size_t)f->id.at[q],
                             3 * sizeof(double)) != 0) {
            return 0;
        } else {
            f->local.at[f->id.at[p]] = q;
        }
    }
    f->order.count = kept;
    return 1;
}

/* ---- a triangulation of the points ---- */

static void pbwio__set_link(pbwio__facet *f, pbw_index code, pbw_index other, int wall)
{
    f->triangles.at[code / 4].link[code % 4] = other;
    f->triangles.at[code / 4].wall[code % 4] = (unsigned char)wall;
    if (other != PBW_NONE) {
        f->triangles.at[other / 4].link[other % 4] = code;
        f->triangles.at[other / 4].wall[other % 4] = (unsigned char)wall;
    }
}

/* Makes triangle t.  Returns 4 t. */
static pbw_index pbwio__set_triangle(pbwio__facet *f, pbw_index t, pbw_index a, pbw_index b, pbw_index c)
{
    pbwio__flat *triangle = f->triangles.at + t;
    memset(triangle, 0, sizeof *triangle);
    memset(triangle->link, 0xff, sizeof triangle->link);             /* PBW_NONE */
    triangle->v[0] = a;
    triangle->v[1] = b;
    triangle->v[2] = c;
    f->degree.at[a]++;
    f->degree.at[b]++;
    f->degree.at[c]++;
    return 4 * t;
}

/* Puts vertices p and q next to each other on the hull. */
static void pbwio__join(pbwio__facet *f, pbw_index p, pbw_index q, pbw_index edge)
{
    f->next.at[p] = q;
    f->before.at[q] = p;
    f->edge.at[p] = edge;
}

/* Triangulates the points up to the first one, number `apex` in the order, that is not on a line with all before. */
static void pbwio__start_hull(pbwio__facet *f, size_t apex)
{
    const pbw_index *o = f->order.at, top = o[apex];
    const int left = pbwio__turn_of(f, o[0], o[1], top) > 0;
    pbw_index code = PBW_NONE, first = PBW_NONE;
    size_t i;
    for (i = 0; i + 1 < apex; i++) {
        const pbw_index last = code;
        code = pbwio__set_triangle(f, (pbw_index)f->triangles.count++, o[left ? i : i + 1], o[left ? i + 1 : i], top);
        if (i > 0) {
            pbwio__set_link(f, left ? code + 1 : code, left ? last : last + 1, 0);
        } else {
            first = code;
        }
        pbwio__join(f, o[left ? i : i + 1], o[left ? i + 1 : i], code + 2);
    }
    if (left) {
        pbwio__join(f, o[apex - 1], top, code);
        pbwio__join(f, top, o[0], first + 1);
    } else {
        pbwio__join(f, o[0], top, first);
        pbwio__join(f, top, o[apex - 1], code + 1);
    }
}

/* Triangulates the points, unless all are on one line; then there are no triangles. */
static void pbwio__sweep_points(pbwio__facet *f)
{
    const pbw_index *o = f->order.at;
    size_t i, apex = 2;
    int k;
    f->triangles.count = 0;
    while (apex < f->order.count && pbwio__turn_of(f, o[0], o[1], o[apex]) == 0) {
        apex++;
    }
    if (apex >= f->order.count) {
        return;
    }
    pbwio__start_hull(f, apex);
    for (i = apex + 1; i < f->order.count; i++) {
        const pbw_index p = o[i];
        pbw_index a = o[i - 1], left, code = PBW_NONE, first = PBW_NONE;
        while (pbwio__turn_of(f, f->before.at[a], a, p) < 0) {
            a = f->before.at[a];
        }
        for (left = a; pbwio__turn_of(f, a, f->next.at[a], p) < 0; a = f->next.at[a]) {
            const pbw_index last = code;
            code = pbwio__set_triangle(f, (pbw_index)f->triangles.count++, p, f->next.at[a], a);
            pbwio__set_link(f, code, f->edge.at[a], 0);
            if (last == PBW_NONE) {
                first = code;
            } else {
                pbwio__set_link(f, code + 1, last + 2, 0);
            }
        }
        pbwio__join(f, left, p, first + 1);
        pbwio__join(f, p, a, code + 2);
    }
    for (i = 0; i < f->triangles.count; i++) {
        for (k = 0; k < 3; k++) {
            f->edge.at[f->triangles.at[i].v[k]] = (pbw_index)(4 * i) + (pbw_index)k;
        }
    }
}

/* ---- edges of outlines ---- */

/* Links an edge of a new triangle to what is beyond an edge of a chain. */
static void pbwio__attach(pbwio__facet *f, pbw_index code, const pbwio__chained *link)
{
    if (!link->is_hinge) {
        pbwio__set_link(f, code, link->code, link->wall);
    } else if (f->hinges.at[link->code] == PBW_NONE) {
        f->hinges.at[link->code] = code;
    } else {
        pbwio__set_link(f, code, f->hinges.at[link->code], link->wall);
    }
}

/* Fills one side of the inserted edge from a chain's first vertex to its last; side: 1 left, 0 right.  Returns the
   code of that edge. */
static pbw_index pbwio__fill_chain(pbwio__facet *f, int side)
{
    pbwio__chained *stack = f->stack.at;
    size_t i, top = 0;
    for (i = 0; i < f->chains[side].count; i++) {
        pbwio__chained next = f->chains[side].at[i];
        while (top >= 2) {
            const pbw_index p = stack[top - 2].vertex, q = stack[top - 1].vertex, v = next.vertex;
            const int turn = pbwio__turn_of(f, p, q, v);
            pbw_index code;
            if (side ? turn >= 0 : turn <= 0) {
                break;
            }
            code = pbwio__set_triangle(f, f->unused.at[--f->unused.count], p, side ? v : q, side ? q : v);
            pbwio__attach(f, code + (side ? 1 : 2), stack + top - 1);
            pbwio__attach(f, code, &next);
            f->edge.at[p] = code;
            f->edge.at[side ? v : q] = code + 1;
            f->edge.at[side ? q : v] = code + 2;
            next.code = code + (side ? 2 : 1);
            next.wall = next.is_hinge = 0;
            top--;
        }
        stack[top++] = next;
    }
    return stack[top - 1].code;
}

/* Puts a vertex at the end of a chain; code: the edge to it from the one before, of a triangle that goes. */
static int pbwio__extend(pbwio__facet *f, int side, pbw_index vertex, pbw_index code)
{
    pbwio__chained link;
    link.vertex = vertex;
    link.code = code;
    link.wall = code != PBW_NONE && f->triangles.at[code / 4].wall[code % 4];
    link.is_hinge = 0;
    return PBWIO__PUSH(f->r, f->chains[side], link) != 0;
}

static int pbwio__take_out(pbwio__facet *f, pbw_index t)
{
    int k;
    for (k = 0; k < 3; k++) {
        f->degree.at[f->triangles.at[t].v[k]]--;
    }
    f->triangles.at[t].out = 1;
    return PBWIO__PUSH(f->r, f->unused, t) != 0;
}

/* Finds what is beyond the edges of a chain: a triangle that stays, nothing, or the chain again, as an edge may have
   triangles that go on both of its sides: then it is a hinge. */
static int pbwio__find_beyond(pbwio__facet *f, int side)
{
    enum { HINGE = 2 };
    size_t i;
    for (i = 1; i < f->chains[side].count; i++) {
        pbwio__chained *link = f->chains[side].at + i;
        pbwio__flat *own = f->triangles.at + link->code / 4;
        const pbw_index beyond = own->link[link->code % 4];
        link->is_hinge = own->wall[link->code % 4] == HINGE
                      || (beyond != PBW_NONE && f->triangles.at[beyond / 4].out);
        if (link->is_hinge && own->wall[link->code % 4] != HINGE) {  /* its first side */
            f->triangles.at[beyond / 4].link[beyond % 4] = (pbw_index)f->hinges.count;
            f->triangles.at[beyond / 4].wall[beyond % 4] = HINGE;
            link->code = (pbw_index)f->hinges.count;
            if (!PBWIO__PUSH(f->r, f->hinges, PBW_NONE)) {
                return 0;
            }
        } else {
            link->code = beyond;
        }
    }
    return 1;
}

/* The edge from vertex a crosses the one of that code, and so on to b or to the first vertex on it, which is
   returned; PBW_NONE: it crosses another edge, or memory is short. */
static pbw_index pbwio__cross(pbwio__facet *f, pbw_index a, pbw_index b, pbw_index code)
{
    const pbwio__flat *t = f->triangles.at + code / 4;
    const pbw_index first = code - code % 4;
    pbw_index end = PBW_NONE, left;
    int good;
    f->chains[0].count = f->chains[1].count = f->unused.count = f->hinges.count = 0;
    good = pbwio__extend(f, 0, a, PBW_NONE) && pbwio__extend(f, 1, a, PBW_NONE)
        && pbwio__extend(f, 0, t->v[(code % 4 + 1) % 3], first + (code % 4 + 2) % 3)
        && pbwio__extend(f, 1, t->v[(code % 4 + 2) % 3], first + (code % 4 + 1) % 3)
        && pbwio__take_out(f, code / 4);
    while (good && end == PBW_NONE) {
        const pbwio__flat *from = f->triangles.at + code / 4;
        const pbw_index next = from->link[code % 4], base = next - next % 4;
        pbw_index apex;
        int side;
        if (from->wall[code % 4]) {
            return PBW_NONE;
        }
        apex = f->triangles.at[next / 4].v[next % 4];
        side = pbwio__turn_of(f, a, b, apex);
        good = (side < 0 || pbwio__extend(f, 1, apex, base + (next % 4 + 2) % 3))
            && (side > 0 || pbwio__extend(f, 0, apex, base + (next % 4 + 1) % 3)) && pbwio__take_out(f, next / 4);
        end = side == 0 ? apex : PBW_NONE;
        code = base + (next % 4 + (side > 0 ? 1u : 2u)) % 3;
    }
    if (!good || !pbwio__find_beyond(f, 0) || !pbwio__find_beyond(f, 1)
        || !PBWIO__ROOM(f->r, f->stack, f->chains[0].count + f->chains[1].count)) {
        return PBW_NONE;
    }
    left = pbwio__fill_chain(f, 1);
    pbwio__set_link(f, pbwio__fill_chain(f, 0), left, 1);
    return end;
}

/* Inserts the edge from vertex a to b, or its first part, to the vertex on it that is returned; PBW_NONE: it crosses
   another edge. */
static pbw_index pbwio__insert_part(pbwio__facet *f, pbw_index a, pbw_index b)
{
    const pbw_index start = f->edge.at[a];
    pbw_index code = start;
    int turn, k;
    for (turn = 0; turn < 2; turn++) {               /* around a, from `start` on counter-clockwise, then clockwise */
        code = turn == 0 ? start : f->triangles.at[start / 4].link[(start % 4 + 2) % 3];
        code = turn == 0 || code == PBW_NONE ? code : code - code % 4 + (code % 4 + 2) % 3;
        while (code != PBW_NONE) {
            const pbwio__flat *t = f->triangles.at + code / 4;
            const unsigned i = code % 4;
            int sides[2];
            for (k = 0; k < 2; k++) {
                const pbw_index v = t->v[(i + 1 + (unsigned)k) % 3];
                sides[k] = pbwio__turn_of(f, a, b, v);
                if (sides[k] == 0 && pbwio__left_of(f->xy.at, a, b) == pbwio__left_of(f->xy.at, a, v)) {
                    const pbw_index edge = code - i + (i + 2 - (unsigned)k) % 3;
                    pbwio__set_link(f, edge, f->triangles.at[edge / 4].link[edge % 4], 1);
                    return v;
                }
            }
            if (sides[0] < 0 && sides[1] > 0) {
                return pbwio__cross(f, a, b, code);
            }
            code = t->link[(i + (turn == 0 ? 1u : 2u)) % 3];
            code = code == PBW_NONE ? code : code - code % 4 + (code % 4 + (turn == 0 ? 1u : 2u)) % 3;
            if (code == start) {
                return PBW_NONE;
            }
        }
    }
    return PBW_NONE;
}

/* Inserts the edges of an outline: one of two corners is a line, of one a point.  Returns what is wrong, or NULL. */
static const char *pbwio__insert_outline(pbwio__facet *f, size_t from, size_t to)
{
    size_t i;
    for (i = from; i < to - (to - from < 3); i++) {
        pbw_index a = f->local.at[f->corners.at[i]], b = f->local.at[f->corners.at[i + 1 < to ? i + 1 : from]], swap;
        if (f->degree.at[a] > f->degree.at[b]) {
            swap = a;
            a = b;
            b = swap;
        }
        if (i % 1024 == 0 && pbwio__stops(f->r->options->build, 0)) {
            pbwio__fail(f->r, PBWIO_CANCELLED, "cancelled");
        }
        while (a != b && f->r->status == PBWIO_OK) {
            a = pbwio__insert_part(f, a, b);
            if (a == PBW_NONE) {
                return "edges of a facet cross";
            }
            if (f->id.at[a] == PBW_NONE) {
                return "the point of a hole lies on an edge of its facet";
            }
        }
    }
    return NULL;
}

/* Takes away what is reached from outside or from a point in a hole without crossing an edge. */
static void pbwio__take_away(pbwio__facet *f)
{
    size_t i;
    int k;
    f->unused.count = 0;
    for (i = 0; i < f->triangles.count && f->r->status == PBWIO_OK; i++) {
        pbwio__flat *t = f->triangles.at + i;
        int out = 0;
        for (k = 0; k < 3; k++) {
            out |= f->id.at[t->v[k]] == PBW_NONE || (t->link[k] == PBW_NONE && !t->wall[k]);
        }
        if (out && !t->out) {
            t->out = 1;
            (void)PBWIO__PUSH(f->r, f->unused, (pbw_index)i);
        }
        while (f->unused.count > 0) {
            const pbwio__flat *at = f->triangles.at + f->unused.at[--f->unused.count];
            for (k = 0; k < 3; k++) {
                const pbw_index next = at->link[k];
                if (next != PBW_NONE && !at->wall[k] && !f->triangles.at[next / 4].out) {
                    f->triangles.at[next / 4].out = 1;
                    (void)PBWIO__PUSH(f->r, f->unused, next / 4);
                }
            }
        }
    }
}

/* Gives the cloud the triangles of the facet, and its lines. */
static void pbwio__keep_facet(pbwio__facet *f)
{
    pbw_index line[2];
    size_t i, k;
    for (i = 0; i < f->triangles.count && f->r->status == PBWIO_OK; i++) {
        const pbwio__flat *t = f->triangles.at + i;
        if (!t->out) {
            pbwio__add_triangle(f->r, f->id.at[t->v[0]], f->id.at[t->v[1]], f->id.at[t->v[2]]);
        }
        for (k = 0; k < 3; k++) {
            const pbw_index next = t->link[k];
            const int beyond = next != PBW_NONE && !f->triangles.at[next / 4].out;
            if (t->wall[k] && beyond == !t->out && (next == PBW_NONE || 4 * i + k < next)) {
                line[0] = f->id.at[t->v[(k + 1) % 3]];
                line[1] = f->id.at[t->v[(k + 2) % 3]];
                pbwio__add_simplex(f->r, 1, line);
            }
        }
    }
}

/* The facet of one outline, as a fan; returns whether that fits. */
static int pbwio__add_fan(pbwio__facet *f, const int axis[2])
{
    const pbw_index *c = f->corners.at;
    const size_t n = f->corners.count, first = f->r->cloud->triangle_count;
    size_t i;
    for (i = 2; i < n; i++) {
        pbwio__add_triangle(f->r, c[0], c[i - 1], c[i]);
    }
    if (f->r->status != PBWIO_OK || pbwio__fan_fits(f->r->cloud, f->r->cloud->triangles + 3 * first, n, axis)) {
        return 1;
    }
    f->r->cloud->triangle_count = first;
    return 0;
}

/* Adds the facet at hand to the cloud. */
static void pbwio__add_facet(pbwio__facet *f)
{
    pbwio__reader *r = f->r;
    const char *wrong = NULL;
    size_t i, from = 0;
    int axis[2];
    if (f->corners.count == 0 || f->corners.count >= PBW_NONE / 16) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "a facet of %zu corners", f->corners.count);
    }
    if (r->status != PBWIO_OK) {
        return;
    }
    pbwio__project(f, axis);
    if (f->ends.count == 1 && f->corners.count > 2 && f->holes.count == 0 && pbwio__add_fan(f, axis)) {
        return;
    }
    if (!pbwio__place_corners(f, axis)) {
        wrong = "a facet has points at one place, or so as seen across it";
    }
    if (wrong == NULL && r->status == PBWIO_OK) {
        pbwio__sweep_points(f);
    }
    for (i = 0; i < f->ends.count && wrong == NULL && r->status == PBWIO_OK; from = f->ends.at[i++]) {
        if (f->triangles.count == 0) {                               /* all are on one line */
            if (f->ends.at[i] - from == 2) {
                pbwio__add_simplex(r, 1, f->corners.at + from);
            } else if (f->ends.at[i] - from > 2) {
                wrong = "the corners of a facet are on one line";
            }
        } else {
            wrong = pbwio__insert_outline(f, from, f->ends.at[i]);
        }
    }
    if (wrong != NULL && r->status == PBWIO_OK) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%s", wrong);
    }
    if (r->status == PBWIO_OK && f->triangles.count > 0) {
        pbwio__take_away(f);
        pbwio__keep_facet(f);
    }
    for (i = 0; i < f->corners.count; i++) {
        f->local.at[f->corners.at[i]] = PBW_NONE;
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>rows         Formats with a line for each point: tables, .node, .obj, .off.
   In: the reader at the start of the file.  Out: the cloud.
   Holds: a first line of counts is passed only where the rows below agree with it.
   ------------------------------------------------------------------------------------------------------ */

/* How many lines there are from here on; with a letter, only those whose first word is that letter. */
static size_t pbwio__count_lines(const pbwio__reader *r, char letter)
{
    const char *s = r->at;
    size_t count = 0;
    while (s != NULL && s < r->end) {
        if (letter != 0) {
            while (s < r->end && pbwio__blank(r, *s) && *s != '\n') {
                s++;
            }
        }
        count += letter == 0 || (r->end - s >= 2 && *s == letter && pbwio__blank(r, s[1]));
        s = s < r->end ? (const char *)memchr(s, '\n', (size_t)(r->end - s)) : NULL;
        s = s != NULL ? s + 1 : NULL;
    }
    return count;
}

/* What a row is made of. */
typedef struct pbwio__shape {
    int columns, numbers, naturals;          /* numbers: fields that start like one */
    int letter;                              /* the first field starts with a letter */
    long long first, second;                 /* the first two fields, where they are natural numbers */
} pbwio__shape;

static pbwio__shape pbwio__shape_of(pbwio__reader *r)
{
    pbwio__shape shape;
    pbwio__field field;
    long long value;
    memset(&shape, 0, sizeof shape);
    for (r->cursor = r->line, r->over = 0; pbwio__next(r, &field); shape.columns++) {
        int letter = field.begin < field.end ? *field.begin | 32 : 0;
        shape.numbers += field.begin < field.end && memchr("+-.0123456789", *field.begin, 13) != NULL;
        shape.letter |= shape.columns == 0 && letter >= 'a' && letter <= 'z';
        if (pbwio__natural(field, &value)) {
            shape.naturals++;
            shape.first = shape.columns == 0 ? value : shape.first;
            shape.second = shape.columns == 1 ? value : shape.second;
        }
    }
    return shape;
}

static pbwio__shape pbwio__next_shape(pbwio__reader *r)
{
    pbwio__shape none;
    memset(&none, 0, sizeof none);
    return pbwio__row_line(r) ? pbwio__shape_of(r) : none;
}

/* Chemistry's .xyz: a count, a comment, then a symbol, x, y, z and perhaps more in each line.  Reads it and returns 1
   if the third line looks so; head: behind the first line. */
static int pbwio__read_molecule(pbwio__reader *r, pbwio__reader head, long long count)
{
    static const char names[] = "symbol x y z";
    pbwio__field name[4] = { { names, names + 6 }, { names + 7, names + 8 }, { names + 9, names + 10 },
                             { names + 11, names + 12 } };
    pbwio__reader rows;
    pbwio__shape shape;
    long long i;
    if (!pbwio__line(&head)) {
        return 0;
    }
    rows = head;
    shape = pbwio__line(&head) ? pbwio__shape_of(&head) : pbwio__next_shape(&head);
    if (!shape.letter || shape.columns < 4 || shape.numbers < 3) {
        return 0;
    }
    r->at = rows.at;
    r->line_number = rows.line_number;
    pbwio__choose(r, name, 4, shape.columns);
    pbwio__reserve(r, (unsigned long long)count, 8);
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        if (!pbwio__row_line(r)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends after %lld of %lld atoms", i, count);
        }
        pbwio__point(r);
    }
    if (pbwio__row_line(r)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "more than %lld atoms: files of one frame are read", count);
    }
    return 1;
}

/* Passes a first line of natural numbers that is the count of a .pts file or a molecule, the dimension before the
   count (Qhull), or a count and a dimension or other numbers.  Refuses one that may as well be a point.  Returns 1 if
   all is read. */
static int pbwio__pass_counts(pbwio__reader *r)
{
    pbwio__reader look = *r, after;
    pbwio__shape head, row;
    size_t rows = 1;
    int counted;
    look.report_at = NULL;
    head = pbwio__next_shape(&look);
    if (head.columns == 0 || head.naturals < head.columns) {
        return 0;
    }
    if (head.columns == 1 && pbwio__read_molecule(r, look, head.first)) {
        return 1;
    }
    after = look;
    row = pbwio__next_shape(&look);
    if (head.columns == 1 && row.columns == 1 && row.naturals == 1 && (head.first == 2 || head.first == 3)) {
        pbwio__reader second = look;
        row = pbwio__next_shape(&look);
        after = row.columns == head.first ? second : after;
    }
    if (head.columns > 1 && row.columns > 1) {
        while (pbwio__row_line(&look)) {
            rows++;
        }
        counted = rows == (unsigned long long)head.first || rows == (unsigned long long)(head.first + head.second);
        counted = counted && head.first >= 4;                        /* of fewer rows a point may be the count */
        if (head.columns != row.columns && head.second == row.columns && !counted && head.first >= 4) {
            pbwio__fail(&after, PBWIO_ERROR_FORMAT, "%lld points are announced, %zu row%s", head.first, rows,
                        rows == 1 ? " follows" : "s follow");
        } else if (counted && head.columns == row.columns && row.naturals < row.numbers) {
            pbwio__fail(&after, PBWIO_ERROR_FORMAT, "this looks like a header of counts, %zu rows follow: remove it, "
                        "or write it with decimal points if it is a point", rows);
        } else if (!counted || head.columns == row.columns) {
            head.columns = 0;
        } else if (rows != (unsigned long long)head.first) {
            pbwio__fail(&after, PBWIO_ERROR_FORMAT, "counts of points and faces: this looks like .off without its "
                        "name");
        }
        r->status = after.status;
    }
    if (head.columns == 1 || (head.columns > 0 && row.columns > 1)) {
        r->at = after.at;
        r->line_number = after.line_number;
    }
    return 0;
}

/* Finds the column of markers, unless it is one of the coordinates or the weight. */
static void pbwio__find_markers(pbwio__reader *r, const pbwio__field *names, int name_count)
{
    const int column = pbwio__find(names, name_count, "marker", 6);
    int k;
    r->marker = column + 1;
    for (k = 0; k < 4; k++) {
        r->marker = r->column[k] == column ? 0 : r->marker;
    }
}

/* Puts the last point into the group of its marker; 0 or nothing: none. */
static void pbwio__mark_point(pbwio__reader *r)
{
    double value = 0;
    if (r->marked.begin == r->marked.end) {
        return;
    }
    if (!pbwio__decimal(r->marked.begin, r->marked.end, r->mark, &value) || !(fabs(value) <= 1e15)
        || fabs(value - floor(value)) > 0) {
        pbwio__report_once(r, "markers that are no whole numbers");
    } else if (fabs(value) > 0) {
        r->group[0] = pbwio__find_group(r, 0, (long long)value, NULL, 0);
        pbwio__group_point(r, r->cloud->count - 1);
    }
}

/* The first lines tell the separator, the names and the number of columns: a first line in which nothing starts like
   a number is a header. */
static void pbwio__read_table(pbwio__reader *r)
{
    pbwio__field names[PBWIO__MOST_COLUMNS], columns[PBWIO__MOST_COLUMNS];
    pbwio__reader head = *r;
    int name_count = 0, count, numbers, first;
    size_t length;
    r->mark = r->options->flags & PBWIO_DECIMAL_COMMA ? ',' : '.';
    if (pbwio__row_line(&head)) {
        length = (size_t)(head.line_end - head.line);
        r->separator = memchr(head.line, ';', length) ? ';'
                     : r->mark == '.' && memchr(head.line, ',', length) ? ',' : 0;
    }
    if (pbwio__pass_counts(r)) {
        return;
    }
    for (first = 1; pbwio__row_line(r); first = 0) {
        for (count = numbers = 0; count < PBWIO__MOST_COLUMNS && pbwio__next(r, &columns[count]); count++) {
            const char *s = columns[count].begin;
            numbers += s < columns[count].end && memchr("+-.0123456789", *s, 13) != NULL;
        }
        if (first && numbers == 0) {
            memcpy(names, columns, sizeof columns);
            name_count = count;
            r->names_line = r->line_number;
            continue;
        }
        pbwio__choose(r, names, name_count, count);
        r->at = r->line;
        r->line_number--;
        pbwio__reserve(r, pbwio__most(r, pbwio__count_lines(r, 0)), 1);
        pbwio__report_columns(r, names, name_count, count);
        pbwio__find_markers(r, names, name_count);
        pbwio__keep_columns(r, names, name_count, columns, count);
        r->marker = r->marker > 0 && r->kept[r->marker - 1] ? 0 : r->marker;
        while (pbwio__row_line(r)) {
            pbwio__point(r);
            if (r->marker > 0 && r->status == PBWIO_OK) {
                pbwio__mark_point(r);
            }
        }
    }
}

/* Room for the attributes of a .node file, but the weight. */
static void pbwio__node_columns(pbwio__reader *r, long long dim, long long attributes)
{
    pbwio_cloud *cloud = r->cloud;
    const size_t count = (size_t)attributes - (r->column[3] >= dim && r->column[3] < dim + attributes);
    if (r->status != PBWIO_OK || count == 0 || r->point_capacity == 0) {
        return;
    }
    (void)pbwio__fit_cloud(r, PBWIO__OF_COLUMNS, &cloud->columns, count, sizeof *cloud->columns);
    for (; cloud->columns != NULL && cloud->column_count < count && r->status == PBWIO_OK; cloud->column_count++) {
        pbwio_column *column = cloud->columns + cloud->column_count;
        column->name = NULL;
        column->values = pbwio__column_values(r);
    }
}

/* The attributes and the marker of the last point, from the fields after its number. */
static void pbwio__node_row(pbwio__reader *r, long long dim, long long attributes, int has_marker)
{
    pbwio_cloud *cloud = r->cloud;
    const size_t point = cloud->count - 1;
    double value = 0;
    long long i;
    size_t k = 0;
    pbwio__field field;
    for (i = 0; i < dim + attributes + has_marker && pbwio__next(r, &field) && r->status == PBWIO_OK; i++) {
        if (i >= dim && !pbwio__number(field.begin, field.end, &value)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "column %lld, \"%s\", is not a finite number", i + 1,
                        pbwio__show(r, field));
        } else if (i >= dim && i < dim + attributes && i != r->column[3]) {
            cloud->columns[k++].values[point] = value;
        } else if (i == dim + attributes && (value < 0 || value > 0)) {
            r->group[0] = pbwio__find_group(r, 0, value >= -1e15 && value <= 1e15 ? (long long)value : 0, NULL, 0);
            pbwio__group_point(r, point);
        }
    }
    if (i < dim + attributes) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%lld column%s where %lld are needed", i, i == 1 ? "" : "s",
                    dim + attributes);
    }
}

/* "count dim attributes markers", then "id x y (z) attributes marker" with ids from 0 or 1. */
static void pbwio__read_node(pbwio__reader *r)
{
    long long count, dim, attributes, markers, first = 0, id, i;
    const char *row;
    pbwio__row_line(r);
    count = pbwio__count(r, "number of points");
    dim = pbwio__count(r, "dimension");
    attributes = pbwio__has_more(r) ? pbwio__count(r, "number of attributes") : 0;
    markers = pbwio__has_more(r) ? pbwio__count(r, "number of markers") : 0;
    if (dim < 2 || dim > 3 || attributes > 1000 || markers > 1) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "dimension %lld, %lld attributes, %lld markers", dim, attributes, markers);
        return;
    }
    pbwio__choose(r, NULL, (int)dim, (int)(dim + attributes + markers));
    pbwio__reserve(r, (unsigned long long)count, 2 * (size_t)(dim + attributes + markers + 1));
    pbwio__node_columns(r, dim, attributes);
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        if (!pbwio__row_line(r)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends after %lld of %lld points", i, count);
        }
        id = pbwio__count(r, "point number");
        first = i == 0 && id == 1 ? 1 : first;
        if (id != first + i) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "point number %lld where %lld is due", id, first + i);
        }
        row = r->cursor;
        pbwio__point(r);
        if (r->status == PBWIO_OK) {
            r->cursor = row;
            pbwio__node_row(r, dim, attributes, (int)markers);
        }
    }
    r->cloud->base = (int)first;
}

/* What is left of the line, without the blanks around it. */
static pbwio__field pbwio__rest(pbwio__reader *r)
{
    pbwio__field field, rest;
    rest.begin = rest.end = r->cursor;
    while (pbwio__next(r, &field)) {
        rest.begin = rest.end == rest.begin ? field.begin : rest.begin;
        rest.end = field.end;
    }
    return rest;
}

/* The word that names the groups of faces: usemtl if it names several, else g, else o; NULL: none of them does. */
static const char *pbwio__obj_word(pbwio__reader r, pbwio__reader *all)
{
    static const char *const words[] = { "usemtl", "g", "o" };
    pbwio__field first[3], word;
    int several[3] = { 0, 0, 0 }, faces = 0, k;
    memset(first, 0, sizeof first);
    while (pbwio__line(&r)) {
        faces |= r.line_end - r.line > 1 && r.line[0] == 'f' && pbwio__blank(&r, r.line[1]);
        for (k = 0; k < 3 && pbwio__next(&r, &word); k++, r.cursor = r.line) {
            if (pbwio__is(word, words[k])) {
                pbwio__field name = pbwio__rest(&r);
                several[k] |= first[k].begin == NULL && faces;       /* those are in none */
                first[k] = first[k].begin == NULL ? name : first[k];
                several[k] |= name.end - name.begin != first[k].end - first[k].begin
                           || memcmp(name.begin, first[k].begin, (size_t)(name.end - name.begin)) != 0;
            }
        }
    }
    for (k = 0; k < 2; k++) {
        if (several[k] && several[k + 1] + several[2] > 0) {
            pbwio__report_once(all, k == 0 ? "groups of faces but those by usemtl"
                               : "groups of faces but those by g");
            break;
        }
    }
    for (k = 0; k < 3 && !several[k]; k++) {
    }
    return k < 3 ? words[k] : NULL;
}

/* A face corner is id, id/texture, id//normal or id/texture/normal; ids start at 1, -1 is the last point so far. */
static void pbwio__read_obj(pbwio__reader *r)
{
    pbwio__field field, number;
    long long total, id, k;
    const char *group;
    pbwio__choose(r, NULL, 3, 0);
    pbwio__reserve(r, pbwio__most(r, pbwio__count_lines(r, 'v')), 1);
    total = (long long)r->point_capacity;
    r->passes = 2;
    group = pbwio__obj_word(*r, r);
    r->pass = 1;
    while (pbwio__line(r)) {
        while (r->line_end > r->line && r->line_end[-1] == '\\' && r->at < r->end) {       /* continued */
            const char *line = r->line;
            pbwio__line(r);
            r->line = r->cursor = line;
            r->joined = 1;
        }
        if (!pbwio__next(r, &field)) {
            continue;
        }
        if (group != NULL && pbwio__is(field, group)) {
            const pbwio__field name = pbwio__rest(r);
            r->group[2] = name.end == name.begin ? PBW_NONE
                        : pbwio__find_group(r, 2, 0, name.begin, (size_t)(name.end - name.begin));
        } else if (pbwio__is(field, "v")) {
            pbwio__point(r);
        } else if (pbwio__is(field, "f")) {
            for (k = 0; pbwio__next(r, &field); k++) {
                int minus = *field.begin == '-';
                number.begin = number.end = field.begin + minus;
                while (number.end < field.end && *number.end != '/') {
                    number.end++;
                }
                if (!pbwio__natural(number, &id) || id == 0) {
                    pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is no corner of a face", pbwio__show(r, field));
                } else if (id > (minus ? (long long)r->cloud->count : total)) {
                    pbwio__fail(r, PBWIO_ERROR_FORMAT, "a face has point %s, there are %lld",
                                pbwio__show(r, field), minus ? (long long)r->cloud->count : total);
                } else {
                    pbwio__add_corner(r, (double)(minus ? (long long)r->cloud->count - id : id - 1), total, k);
                }
            }
            if (k < 3) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "a face of %lld corner%s", k, k == 1 ? "" : "s");
            }
        } else if (memchr(field.begin, 0, (size_t)(field.end - field.begin)) != NULL) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "a zero byte: this is not text");
        }
    }
    if (r->cloud->count < r->point_capacity && r->cloud->triangle_count != 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "points: %zu, announced: %zu", r->cloud->count, r->point_capacity);
    }
}

/* "OFF", with letters before it for colours, normals, texture: columns after z; the counts; the points; the faces. */
static void pbwio__read_off(pbwio__reader *r)
{
    long long points, faces, corners, i, k;
    pbwio__field field;
    pbwio__row_line(r);
    pbwio__next(r, &field);
    if (field.end - field.begin >= 3 && pbwio__same(field.end - 3, 3, "OFF", 3)) {       /* the word may be missing */
        for (; field.end - field.begin > 3; field.begin++) {
            if (memchr("STCN", *field.begin, 4) == NULL) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "files of kind \"%s\" are not read", pbwio__show(r, field));
            }
            if (r->options->columns == NULL && r->options->weight == NULL) {
                pbwio__report_once(r, "colours, normals, texture");
            }
        }
        if (!pbwio__next(r, &field)) {
            pbwio__row_line(r);
            pbwio__next(r, &field);
        }
    }
    if (pbwio__is(field, "BINARY")) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "binary OFF is not read");
    }
    r->cursor = field.begin;
    points = pbwio__count(r, "number of points");
    faces = pbwio__count(r, "number of faces");
    pbwio__choose(r, NULL, 3, 0);
    pbwio__reserve(r, (unsigned long long)points, 2 * (size_t)(r->last_column + 1));
    for (i = 0; i < points && r->status == PBWIO_OK; i++) {
        if (!pbwio__row_line(r)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends after %lld of %lld points", i, points);
        }
        pbwio__point(r);
    }
    for (i = 0; i < faces && r->status == PBWIO_OK; i++) {
        if (!pbwio__row_line(r)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends after %lld of %lld faces", i, faces);
        }
        corners = pbwio__count(r, "number of corners");
        for (k = 0; k < corners && r->status == PBWIO_OK; k++) {
            pbwio__add_corner(r, (double)pbwio__count(r, "corner"), points, k);
        }
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>binary       Formats in text or binary: .stl, .ply.
   In: the reader at the start of the file.  Out: the cloud.
   Holds: binary values are read byte by byte, in the file's byte order, whatever that of the machine.
   ------------------------------------------------------------------------------------------------------ */
static const struct { const char *name, *old_name; size_t size; } pbwio__types[] = {
    { "int8", "char", 1 }, { "uint8", "uchar", 1 }, { "int16", "short", 2 }, { "uint16", "ushort", 2 },
    { "int32", "int", 4 }, { "uint32", "uint", 4 }, { "float32", "float", 4 }, { "float64", "double", 8 },
    { "int64", "", 8 }, { "uint64", "", 8 }                          /* not in .ply */
};

/* The next value of a type out of the table, in the byte order of the file. */
static double pbwio__binary(pbwio__reader *r, int type, int big)
{
    size_t size = pbwio__types[type].size, i;
    uint64_t bits = 0;
    uint32_t low;
    double x;
    float f;
    if (r->report_at != NULL && r->at >= r->report_at) {
        pbwio__report(r);
    }
    if (r->status != PBWIO_OK || (size_t)(r->end - r->at) < size) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends too early");
        return 0;
    }
    for (i = 0; i < size; i++) {
        bits |= (uint64_t)(unsigned char)r->at[big ? size - 1 - i : i] << (8 * i);
    }
    low = (uint32_t)bits;
    memcpy(&x, &bits, sizeof x);
    memcpy(&f, &low, sizeof f);
    r->at += size;
    return type == 7 ? x : type == 6 ? (double)f : type % 2 == 0 && bits >> (8 * size - 1) ?
           (double)bits - ldexp(1.0, (int)(8 * size)) : (double)bits;
}

static int pbwio__finite(double x)
{
    return x <= DBL_MAX && x >= -DBL_MAX;
}

static void pbwio__read_stl_binary(pbwio__reader *r, size_t count)
{
    double row[12], value[4] = { 0, 0, 0, 0 };
    const size_t left = (size_t)(r->end - r->at) - 84;
    size_t i, n;
    int k;
    r->at += 84;
    r->line_number = 0;
    if ((count == 0 || count == 0xffffffff) && left > 0 && left % 50 == 0) {     /* as writers of streams leave it */
        pbwio__report_dropped(r, "the number %zu of triangles in the head, %zu follow", count, left / 50);
        count = left / 50;
    } else if (left / 50 < count) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%zu triangle%s announced, %zu byte%s", count,
                    count == 1 ? " is" : "s are", left, left == 1 ? " follows" : "s follow");
    } else if (left > 50 * count) {
        pbwio__report_dropped(r, "%zu byte%s behind the triangles", left - 50 * count,
                              left - 50 * count == 1 ? "" : "s");
    }
    pbwio__reserve(r, 3 * (unsigned long long)count, 16);
    for (i = 0; i < count && r->status == PBWIO_OK; i++, r->at += 2) {
        for (n = 0; n < 12; n++) {                                   /* the normal, then three corners */
            row[n] = pbwio__binary(r, 6, 0);
        }
        for (n = 1; n < 4; n++) {
            for (k = 0; k < 4; k++) {
                value[k] = r->column[k] >= 0 ? row[3 * n + (size_t)r->column[k]] : 0;
                if (!pbwio__finite(value[k])) {
                    pbwio__fail(r, PBWIO_ERROR_FORMAT, "a coordinate is not a finite number");
                }
            }
            pbwio__add_point(r, value);
        }
        pbwio__add_triangle(r, 3 * i, 3 * i + 1, 3 * i + 2);
    }
}

/* The corners of the facet at hand are complete, or there is none. */
static void pbwio__end_facet(pbwio__reader *r, size_t *corners)
{
    const size_t n = r->cloud->count;
    if (*corners == 3) {
        pbwio__add_triangle(r, n - 3, n - 2, n - 1);
    } else if (*corners != 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "a facet of %zu corner%s", *corners, *corners == 1 ? "" : "s");
    }
    *corners = 0;
}

/* Words in any case, "endloop" or "end loop", however they are spread over lines; what other words say is passed. */
static void pbwio__read_stl_text(pbwio__reader *r)
{
    size_t corners = 0, count = 0;
    pbwio__field field;
    const char *s;
    for (s = r->at; r->end - s >= 6; s++) {
        count += (*s | 32) == 'v' && pbwio__same(s, 6, "vertex", 6);
    }
    pbwio__reserve(r, count, 12);
    while (pbwio__row_line(r)) {
        while (pbwio__next(r, &field)) {
            if (pbwio__is(field, "vertex")) {
                pbwio__point(r);
                corners++;
            } else if (pbwio__is(field, "facet") || pbwio__is(field, "endloop") || pbwio__is(field, "end")) {
                pbwio__end_facet(r, &corners);
            } else if (pbwio__is(field, "solid") || pbwio__is(field, "endsolid")) {
                const int starts = pbwio__is(field, "solid");
                const char *from = NULL, *to = NULL;                 /* the name, which may be any words */
                pbwio__end_facet(r, &corners);
                for (s = r->cursor; pbwio__next(r, &field) && !pbwio__is(field, "facet"); s = to = r->cursor) {
                    from = from == NULL ? field.begin : from;
                }
                r->cursor = s;
                if (starts && r->status == PBWIO_OK) {
                    r->group[2] = from == NULL ? PBW_NONE : pbwio__find_group(r, 2, 0, from, (size_t)(to - from));
                }
            }
        }
    }
    if (corners != 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends inside a facet");
    }
    for (corners = 0; corners < r->cloud->triangle_count && r->cloud->triangle_groups != NULL
         && r->cloud->triangle_groups[corners] != PBW_NONE; corners++) {
    }
    if (r->cloud->group_count == 1 && corners == r->cloud->triangle_count) {   /* the model's name, no part of it */
        pbwio__clear_groups(r);
    }
}

/* A binary file may start with "solid" as a text file does: the length decides, else a zero byte, which text has not
   and binary has in its count below 2^24, in the attribute of the first triangle or in its numbers. */
static void pbwio__read_stl(pbwio__reader *r)
{
    const size_t size = (size_t)(r->end - r->at);
    pbwio__reader head = *r;
    pbwio__field word;
    size_t count;
    int text;
    pbwio__choose(r, NULL, 3, 3);
    head.error = NULL;
    text = pbwio__row_line(&head) && pbwio__next(&head, &word) && pbwio__lists("solid facet", word)
        && memchr(r->at, 0, size < 134 ? size : 134) == NULL;
    head = *r;
    if (size >= 84) {
        head.at += 80;
        count = (size_t)pbwio__binary(&head, 5, 0);
        if (!text || size == 84 + 50 * (unsigned long long)count) {
            pbwio__read_stl_binary(r, count);
            return;
        }
    }
    pbwio__read_stl_text(r);
}

typedef struct pbwio__property {
    pbwio__field name;
    int type, list;                          /* list: the type of its count, -1 = no list */
} pbwio__property;

typedef struct pbwio__ply {
    int text, big;                           /* how numbers are written */
    long long vertex_count, count;           /* count: of the element at hand */
    pbwio__field name;                       /* the element at hand */
    int property_count;
    pbwio__property property[PBWIO__MOST_COLUMNS];
} pbwio__ply;

/* The next value of the body; wanted 0 = it may be anything. */
static double pbwio__ply_value(pbwio__reader *r, const pbwio__ply *ply, int type, int wanted)
{
    pbwio__field field;
    double value = 0;
    if (!ply->text) {
        value = pbwio__binary(r, type, ply->big);
        if (wanted && !pbwio__finite(value)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "a value is not a finite number");
        }
    } else if (!pbwio__next(r, &field)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the line has too few values");
    } else if (wanted && !pbwio__number(field.begin, field.end, &value)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a finite number", pbwio__show(r, field));
    }
    return value;
}

/* Reports properties and elements that are not kept. */
static void pbwio__ply_report(pbwio__reader *r, const pbwio__ply *ply, int vertex, int face)
{
    const pbwio_options *o = r->options;
    int p;
    if (!vertex && !face && ply->count > 0) {
        pbwio__report_unread(r, ply->name);
    }
    for (p = 0; p < ply->property_count && (vertex || face) && o->columns == NULL; p++) {
        const pbwio__field name = ply->property[p].name;
        if (!pbwio__lists(vertex ? "x y z nx ny nz" : "vertex_indices vertex_index", name)
            && (o->weight == NULL || !pbwio__is(name, o->weight))) {
            pbwio__report_unread(r, name);
        }
    }
}

static void pbwio__ply_element(pbwio__reader *r, const pbwio__ply *ply)
{
    int vertex = pbwio__is(ply->name, "vertex"), face = pbwio__is(ply->name, "face"), lists = 0, p, k, corners;
    size_t row = 0;                          /* the fewest bytes of one element */
    double value[4] = { 0, 0, 0, 0 }, length, x;
    pbwio__field names[PBWIO__MOST_COLUMNS];
    long long i, j;
    for (p = 0; p < ply->property_count; p++) {
        const pbwio__property *property = &ply->property[p];
        names[p] = property->name;
        lists |= property->list >= 0;
        row += ply->text ? 2 : pbwio__types[property->list >= 0 ? property->list : property->type].size;
    }
    pbwio__ply_report(r, ply, vertex, face);
    if (vertex && r->cloud->points != NULL) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "element \"vertex\" comes twice");
    } else if (vertex) {
        pbwio__choose(r, names, ply->property_count, ply->property_count);
        for (k = 0; k < 4 && r->status == PBWIO_OK; k++) {
            if (r->column[k] >= 0 && ply->property[r->column[k]].list >= 0) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "column %d is a list", r->column[k] + 1);
            }
        }
        pbwio__reserve(r, (unsigned long long)ply->count, row == 0 ? 1 : row);
    } else if (!ply->text && !lists) {
        if (row != 0 && (size_t)(r->end - r->at) / row < (unsigned long long)ply->count) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends inside element \"%s\"", pbwio__show(r, ply->name));
            return;
        }
        r->at += (size_t)ply->count * row;
        return;
    }
    for (i = 0; i < ply->count && r->status == PBWIO_OK; i++) {
        if (ply->text && !pbwio__row_line(r)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends after %lld of %lld of element \"%s\"", i, ply->count,
                        pbwio__show(r, ply->name));
        }
        for (p = 0; p < ply->property_count && r->status == PBWIO_OK; p++) {
            const pbwio__property *property = &ply->property[p];
            if (property->list < 0) {
                int wanted = 0;
                for (k = 0; k < 4 && vertex; k++) {
                    wanted |= r->column[k] == p;
                }
                x = pbwio__ply_value(r, ply, property->type, wanted);
                for (k = 0; k < 4 && wanted; k++) {
                    value[k] = r->column[k] == p ? x : value[k];
                }
                continue;
            }
            corners = face && (pbwio__is(property->name, "vertex_indices")
                               || pbwio__is(property->name, "vertex_index"));
            length = pbwio__ply_value(r, ply, property->list, 1);
            if (!(length >= 0 && length <= 4294967295.0 && length == floor(length))) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "a list of %g values", length);
            }
            for (j = 0; r->status == PBWIO_OK && (double)j < length; j++) {
                x = pbwio__ply_value(r, ply, property->type, corners);
                if (corners) {
                    pbwio__add_corner(r, x, ply->vertex_count, j);
                }
            }
        }
        if (vertex) {
            pbwio__add_point(r, value);
        }
    }
}

static int pbwio__ply_type(pbwio__reader *r)
{
    pbwio__field field;
    int t;
    pbwio__next(r, &field);
    for (t = 0; t < 8; t++) {
        if (pbwio__is(field, pbwio__types[t].name) || pbwio__is(field, pbwio__types[t].old_name)) {
            return t;
        }
    }
    pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a type", pbwio__show(r, field));
    return 0;
}

/* "property type name" or "property list type type name", after its first word. */
static void pbwio__ply_property(pbwio__reader *r, pbwio__ply *ply)
{
    pbwio__property *property = &ply->property[ply->property_count];
    const char *start = r->cursor;
    pbwio__field field;
    if (ply->property_count == PBWIO__MOST_COLUMNS) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "more than %d properties", PBWIO__MOST_COLUMNS);
        return;
    }
    property->list = -1;
    if (pbwio__next(r, &field) && pbwio__is(field, "list")) {
        property->list = pbwio__ply_type(r);
    } else {
        r->cursor = start;
    }
    property->type = pbwio__ply_type(r);
    if (!pbwio__next(r, &property->name)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "a property without a name");
    }
    ply->property_count++;
}

/* The header is gone through twice: for the format, the number of points and where the body starts; then element by
   element, each read as soon as its properties are known. */
static void pbwio__read_ply(pbwio__reader *r)
{
    pbwio__field word, field;
    pbwio__reader header;
    pbwio__ply ply;
    int known = 0, elements = 0, ended = 0;
    memset(&ply, 0, sizeof ply);
    if (!pbwio__line(r) || !pbwio__next(r, &word) || !pbwio__is(word, "ply")) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the first line is not \"ply\"");
    }
    header = *r;
    while (!ended && pbwio__line(r)) {
        pbwio__next(r, &word);
        ended = pbwio__is(word, "end_header");
        if (pbwio__is(word, "format") && pbwio__next(r, &field)) {
            ply.text = pbwio__is(field, "ascii");
            ply.big = pbwio__is(field, "binary_big_endian");
            known = ply.text || ply.big || pbwio__is(field, "binary_little_endian");
        } else if (pbwio__is(word, "element") && pbwio__next(r, &field) && pbwio__is(field, "vertex")) {
            ply.vertex_count = pbwio__count(r, "number of elements");
        }
    }
    if (!ended || !known) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the header has no %s", ended ? "known format" : "end_header");
    }
    r->line_number = ply.text ? r->line_number : 0;
    for (ended = 0; !ended && r->status == PBWIO_OK && pbwio__line(&header);) {
        if (!pbwio__next(&header, &word)) {
            continue;
        }
        ended = pbwio__is(word, "end_header");
        if (ended || pbwio__is(word, "element")) {
            if (elements++ > 0) {
                pbwio__ply_element(r, &ply);
            }
            ply.property_count = 0;
            pbwio__next(&header, &ply.name);
            ply.count = ended ? 0 : pbwio__count(&header, "number of elements");
        } else if (pbwio__is(word, "property") && elements > 0) {
            pbwio__ply_property(&header, &ply);
        } else if (!pbwio__is(word, "format") && !pbwio__is(word, "comment") && !pbwio__is(word, "obj_info")) {
            pbwio__fail(&header, PBWIO_ERROR_FORMAT, "\"%s\" is no header line", pbwio__show(r, word));
        }
        r->status = r->status == PBWIO_OK ? header.status : r->status;
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>medit        Meshes of Medit, TetGen and Triangle: .mesh, .ele, .face, .edge.
   In: the reader; for .ele .face .edge also the points of the .node file, in the cloud.  Out: elements and groups.
   Holds: corners are points that are there; elements other than triangles, quadrilaterals, tetrahedra and edges are
   named in cloud->dropped.
   ------------------------------------------------------------------------------------------------------ */

/* The next field, on this line or a later one. */
static int pbwio__token(pbwio__reader *r, pbwio__field *field)
{
    while (!pbwio__next(r, field)) {
        if (!pbwio__row_line(r)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends too early");
            return 0;
        }
    }
    return 1;
}

static double pbwio__token_number(pbwio__reader *r)
{
    pbwio__field field;
    double value = 0;
    if (pbwio__token(r, &field) && !pbwio__number(field.begin, field.end, &value)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a finite number", pbwio__show(r, field));
    }
    return value;
}

static long long pbwio__token_count(pbwio__reader *r, const char *what)
{
    pbwio__field field;
    long long value = 0;
    if (pbwio__token(r, &field) && !pbwio__natural(field, &value)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a %s", pbwio__show(r, field), what);
    }
    return value;
}

/* A point from all of its coordinates. */
static void pbwio__add_row(pbwio__reader *r, const double *row)
{
    double value[4] = { 0, 0, 0, 0 };
    int k;
    for (k = 0; k < 3; k++) {
        value[k] = r->column[k] >= 0 ? row[r->column[k]] : 0;
    }
    pbwio__add_point(r, value);
}

#define PBWIO__OTHER_SOLIDS "hexahedra, prisms, pyramids and polyhedra"

/* An element of dimension `dim`, 0 to 3, with the ids of its nodes: first its corners, then points in the middles of
   its edges and so on, which are not kept.  In the plane it may be a polygon.  All of the points are known. */
static void pbwio__add_element(pbwio__reader *r, int dim, int corners, int nodes, const long long *id)
{
    pbw_index corner[4];
    int k;
    for (k = 0; k < nodes; k++) {
        if (id[k] < 0 || (unsigned long long)id[k] >= r->cloud->count) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "an element has a point that is not there, of %zu", r->cloud->count);
            return;
        }
        if (k < corners && k < 4) {
            corner[k] = (pbw_index)id[k];
        }
    }
    if (nodes > corners && r->midpoints.at == NULL) {
        if (!pbwio__fit(r, &r->midpoints.at, &r->midpoints.capacity, r->cloud->count, 1)) {
            return;
        }
        memset(r->midpoints.at, 0, r->cloud->count);
    }
    for (k = corners; k < nodes; k++) {
        r->midpoints.at[id[k]] = 1;
    }
    if (dim == 0) {
        pbwio__group_point(r, (size_t)id[0]);
    } else if (dim != 2) {
        pbwio__add_simplex(r, dim, corner);
    }
    for (k = 0; k < corners && dim == 2; k++) {
        pbwio__add_corner(r, (double)id[k], (long long)r->cloud->count, k);
    }
}

/* Takes out the midpoints of edges and facets that are a corner of none. */
static void pbwio__remove_midpoints(pbwio__reader *r)
{
    pbwio_cloud *cloud = r->cloud;
    pbw_index *const ids[3] = { cloud->segments, cloud->triangles, cloud->tetrahedra }, *number;
    const size_t counts[3] = { 2 * cloud->segment_count, 3 * cloud->triangle_count, 4 * cloud->tetrahedron_count };
    const size_t dim = (size_t)cloud->dim, count = cloud->count;
    size_t i, k, kept = 0;
    number = (pbw_index *)pbwio__resize(r, NULL, 0, count, sizeof *number);
    if (number == NULL) {
        return;
    }
    for (k = 0; k < 3; k++) {
        for (i = 0; i < counts[k]; i++) {
            r->midpoints.at[ids[k][i]] = 0;
        }
    }
    for (i = 0; i < cloud->count; i++) {
        number[i] = (pbw_index)kept;
        if (!r->midpoints.at[i]) {
            memmove(cloud->points + dim * kept, cloud->points + dim * i, dim * sizeof(double));
            if (cloud->weights != NULL) {
                cloud->weights[kept] = cloud->weights[i];
            }
            if (cloud->heights != NULL) {
                cloud->heights[kept] = cloud->heights[i];
            }
            if (cloud->point_groups != NULL) {
                cloud->point_groups[kept] = cloud->point_groups[i];
            }
            for (k = 0; k < cloud->column_count; k++) {
                cloud->columns[k].values[kept] = cloud->columns[k].values[i];
            }
            kept++;
        }
    }
    for (k = 0; k < 3; k++) {
        for (i = 0; i < counts[k]; i++) {
            ids[k][i] = number[ids[k][i]];
        }
    }
    cloud->count = kept;
    pbwio__release(r, number, count, sizeof *number);
    pbwio__report_once(r, "the points within edges and faces of second-order elements, which are read as straight "
                       "ones");
}

/* The elements of Medit by their words; rows of nodes and a reference. */
static const struct { const char *word; int dim, corners, nodes; } pbwio__medit[] = {
    { "Edges", 1, 2, 2 }, { "Triangles", 2, 3, 3 }, { "Quadrilaterals", 2, 4, 4 }, { "Tetrahedra", 3, 4, 4 },
    { "EdgesP2", 1, 2, 3 }, { "TrianglesP2", 2, 3, 6 }, { "QuadrilateralsQ2", 2, 4, 9 }, { "TetrahedraP2", 3, 4, 10 }
};
enum { PBWIO__MEDIT = sizeof pbwio__medit / sizeof pbwio__medit[0] };

/* The reference that comes next is the group of elements of that dimension; 0: none. */
static void pbwio__reference(pbwio__reader *r, int dim)
{
    const double tag = pbwio__token_number(r);
    if (!(fabs(tag) < 1e18)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%g is no reference", tag);
    } else if (r->status == PBWIO_OK) {
        r->group[dim] = (long long)tag == 0 ? PBW_NONE : pbwio__find_group(r, dim, (long long)tag, "", 0);
    }
}

static void pbwio__medit_points(pbwio__reader *r, long long dim)
{
    long long count, i;
    double row[3] = { 0, 0, 0 };
    int k;
    if (dim < 2 || dim > 3 || r->cloud->points != NULL) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "vertices twice, or in %lld dimensions", dim);
    }
    count = pbwio__token_count(r, "number of points");
    pbwio__choose(r, NULL, dim == 2 ? 2 : 3, dim == 2 ? 2 : 3);
    pbwio__reserve(r, (unsigned long long)count, 2 * (size_t)dim + 2);
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        for (k = 0; k < dim && k < 3; k++) {
            row[k] = pbwio__token_number(r);
        }
        pbwio__reference(r, 0);
        pbwio__add_row(r, row);
        pbwio__group_point(r, (size_t)i);
    }
}

/* Medit: keywords, each followed by a count and its rows. */
static void pbwio__read_medit(pbwio__reader *r)
{
    pbwio__field word;
    long long dim = 0, count, i, id[10];
    int k, n;
    while (r->status == PBWIO_OK && (pbwio__next(r, &word) || pbwio__row_line(r))) {
        if (word.begin == word.end || (unsigned)(*word.begin | 32) - 'a' > 25) {
            continue;                                                /* numbers of a section that is passed over */
        }
        for (n = 0; n < PBWIO__MEDIT && !pbwio__is(word, pbwio__medit[n].word); n++) {
        }
        if (pbwio__is(word, "End")) {
            break;
        } else if (pbwio__is(word, "Dimension")) {
            dim = pbwio__token_count(r, "dimension");
        } else if (pbwio__is(word, "Vertices")) {
            pbwio__medit_points(r, dim);
        } else if (n < PBWIO__MEDIT) {
            count = pbwio__token_count(r, "number of elements");
            for (i = 0; i < count && r->status == PBWIO_OK; i++) {
                for (k = 0; k < pbwio__medit[n].nodes; k++) {
                    id[k] = pbwio__token_count(r, "point number") - 1;
                }
                pbwio__reference(r, pbwio__medit[n].dim);
                if (r->status == PBWIO_OK) {
                    pbwio__add_element(r, pbwio__medit[n].dim, pbwio__medit[n].corners, pbwio__medit[n].nodes, id);
                }
            }
        } else if (pbwio__is(word, "Hexahedra") || pbwio__is(word, "Prisms") || pbwio__is(word, "Pentahedra")
                   || pbwio__is(word, "Pyramids")) {
            pbwio__report_once(r, PBWIO__OTHER_SOLIDS);
        } else if (!pbwio__is(word, "MeshVersionFormatted")) {
            pbwio__report_unread(r, word);
        }
    }
}

/* Whether the points of a .node file are there, which this file has not. */
static int pbwio__has_nodes(pbwio__reader *r)
{
    if (r->cloud->count == 0) {
        pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "the points of this file are in the .node file beside it");
    }
    return r->cloud->count > 0;
}

/* Groups of elements of a dimension, which come behind `before` others, are no groups after all. */
static void pbwio__discard_groups(pbwio__reader *r, int dim, size_t before)
{
    pbwio__free_members(r, dim);
    r->group[dim] = PBW_NONE;
    r->cloud->group_count = before;
    pbwio__report_once(r, "attributes of elements, which are no whole numbers and so no regions");
}

/* "count corners attributes", then "id corners attributes"; the points are in the .node file.  Its ids start where
   those of the elements do.  The first attribute, if all are integers, is the group. */
static void pbwio__read_ele(pbwio__reader *r)
{
    const size_t before = r->cloud->group_count;
    long long count, corners, attributes, i, first = 0, id, corner[10];
    pbwio__field field;
    double tag = 0;
    int k, dim = r->cloud->dim;
    if (!pbwio__has_nodes(r)) {
        return;
    }
    count = pbwio__token_count(r, "number of elements");
    corners = pbwio__token_count(r, "number of corners");
    attributes = pbwio__next(r, &field) && pbwio__natural(field, &attributes) ? attributes : 0;
    if (corners != dim + 1 && corners != (dim == 3 ? 10 : 6)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "elements of %lld corners in %dD", corners, dim);
    }
    if (attributes > 1) {
        pbwio__report_once(r, "attributes of elements but the first");
    }
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        if (!pbwio__row_line(r)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends after %lld of %lld elements", i, count);
        }
        id = pbwio__count(r, "element number");
        first = i == 0 ? id : first;
        for (k = 0; k < corners; k++) {
            corner[k] = pbwio__count(r, "point number") - first;
        }
        if (attributes > 0 && (!pbwio__next(r, &field) || !pbwio__number(field.begin, field.end, &tag))) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a finite number", pbwio__show(r, field));
        } else if (attributes > 0 && (tag < floor(tag) || tag > floor(tag) || fabs(tag) >= 1e18)) {
            pbwio__discard_groups(r, dim, before);
            attributes = 0;
        } else if (attributes > 0) {
            r->group[dim] = (long long)tag == 0 ? PBW_NONE : pbwio__find_group(r, dim, (long long)tag, "", 0);
        }
        if (r->status == PBWIO_OK) {
            pbwio__add_element(r, dim, dim + 1, (int)corners, corner);
        }
    }
}

/* .face and .edge: "count markers", then "id corners marker".  The points are in the .node file; the ids of both
   files start with the same number.  Second-order faces have middle points before the marker.  The elements on both
   sides may follow the marker.  Beside simplices, rows without a marker add nothing. */
static void pbwio__read_facets(pbwio__reader *r)
{
    const pbwio_cloud *cloud = r->cloud;
    const int dim = pbwio__lists("edge", pbwio__ending(r->name)) ? 1 : 2, alone = cloud->tetrahedron_count == 0
                 && (cloud->dim == 3 || cloud->triangle_count == 0);
    long long count, markers, i, id[10];
    pbwio__field field;
    int k, minus;
    if (!pbwio__has_nodes(r)) {
        return;
    }
    count = pbwio__token_count(r, "number of rows");
    markers = pbwio__next(r, &field) && pbwio__natural(field, &markers) ? markers : 0;
    if (dim + 1 > cloud->dim || markers > 1) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "faces in the plane, or %lld markers", markers);
    }
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        if (!pbwio__row_line(r)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends after %lld of %lld rows", i, count);
        }
        pbwio__count(r, "number of the row");
        for (k = minus = 0; k < 10 && pbwio__next(r, &field) && r->status == PBWIO_OK; k++) {
            minus = *field.begin == '-';
            field.begin += minus;
            if (!pbwio__natural(field, id + k)) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a number", pbwio__show(r, field));
            }
            id[k] = minus ? -id[k] : k < dim + 1 ? id[k] - cloud->base : id[k];
        }
        if (k < dim + 1 + markers) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "%d numbers where %lld are needed", k + 1, dim + 2 + markers);
        }
        if (dim == 1 && markers > 0 && k > 3) {
            pbwio__report_once(r, "edges with more than two points and a marker");
            continue;
        }
        k = dim == 2 && k == 6 + markers ? 6 : dim + 1;              /* where the marker is */
        r->group[dim] = markers == 0 || id[k] == 0 || r->status != PBWIO_OK ? PBW_NONE
                      : pbwio__find_group(r, dim, id[k], "", 0);
        if (r->status == PBWIO_OK && (alone || r->group[dim] != PBW_NONE)) {
            pbwio__add_element(r, dim, dim + 1, dim + 1, id);
        }
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>poly         Surfaces of TetGen, .poly and .smesh, and domains of Triangle, .poly.
   In: the reader; the points of the .node file, if the file has none.  Out: triangles, in the plane segments; groups
   by markers and attributes; points in holes and regions.
   ------------------------------------------------------------------------------------------------------ */
/* The next line, with a row of a section. */
static void pbwio__next_row(pbwio__reader *r, const char *what)
{
    if (r->status == PBWIO_OK && !pbwio__row_line(r)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends where %s should be", what);
    }
}

/* The marker that comes next, if the file has such, is the group of elements of that dimension. */
static void pbwio__next_marker(pbwio__reader *r, int dim, int has_markers)
{
    r->group[dim] = PBW_NONE;
    if (has_markers && pbwio__has_more(r)) {
        pbwio__reference(r, dim);
    }
}

/* The number of corners of an outline, and the corners, on any number of lines. */
static void pbwio__read_outline(pbwio__facet *f)
{
    pbwio__reader *r = f->r;
    const long long count = pbwio__count(r, "number of corners"), base = r->cloud->base;
    long long i, id;
    if (count == 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "an outline without corners");
    }
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        id = pbwio__token_count(r, "corner") - base;
        if (r->status == PBWIO_OK && (id < 0 || (unsigned long long)id >= r->cloud->count)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "a facet has point %lld, there are %lld to %lld", id + base, base,
                        base + (long long)r->cloud->count - 1);
        }
        (void)(r->status == PBWIO_OK && PBWIO__PUSH(r, f->corners, (pbw_index)id));
    }
    (void)(r->status == PBWIO_OK && PBWIO__PUSH(r, f->ends, (pbw_index)f->corners.count));
}

/* A facet: the numbers of outlines and holes, the marker; the outlines; points in the holes.  In .smesh it is an
   outline, then the marker. */
static void pbwio__read_facet(pbwio__facet *f, int is_smesh, int has_markers)
{
    pbwio__reader *r = f->r;
    long long outlines, holes, i;
    int k;
    f->corners.count = f->ends.count = f->holes.count = 0;
    pbwio__next_row(r, "a facet");
    if (is_smesh) {
        pbwio__read_outline(f);
        pbwio__next_marker(r, 2, has_markers);
        return;
    }
    outlines = pbwio__count(r, "number of outlines");
    holes = pbwio__has_more(r) ? pbwio__count(r, "number of holes") : 0;
    pbwio__next_marker(r, 2, has_markers);
    for (i = 0; i < outlines && r->status == PBWIO_OK; i++) {
        pbwio__next_row(r, "an outline");
        pbwio__read_outline(f);
    }
    for (i = 0; i < holes && r->status == PBWIO_OK; i++) {
        pbwio__next_row(r, "a hole");
        pbwio__count(r, "number of the hole");
        for (k = 0; k < 3; k++) {
            const double x = pbwio__token_number(r);
            (void)(r->status == PBWIO_OK && PBWIO__PUSH(r, f->holes, x));
        }
    }
}

static void pbwio__read_poly_facets(pbwio__reader *r)
{
    const int is_smesh = pbwio__lists("smesh", pbwio__ending(r->name));
    long long count, has_markers, i;
    pbwio__facet f;
    memset(&f, 0, sizeof f);
    f.r = r;
    pbwio__next_row(r, "the number of facets");
    count = pbwio__count(r, "number of facets");
    has_markers = pbwio__has_more(r) ? pbwio__count(r, "number of markers") : 0;
    if (r->status == PBWIO_OK && PBWIO__ROOM(r, f.local, r->cloud->count)) {
        memset(f.local.at, 0xff, r->cloud->count * sizeof *f.local.at);         /* PBW_NONE */
    }
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        pbwio__read_facet(&f, is_smesh, has_markers > 0);
        pbwio__add_facet(&f);
    }
    r->group[1] = r->group[2] = PBW_NONE;
    if (f.bent > 0) {
        pbwio__report_dropped(r, "the flatness of %zu facet%s: corners are up to %.2g beside the plane", f.bent,
                              f.bent == 1 ? "" : "s", f.bend);
    }
    pbwio__release_facet(&f);
}

static void pbwio__read_poly_segments(pbwio__reader *r)
{
    long long count, has_markers, i, id[2];
    int k;
    pbwio__next_row(r, "the number of segments");
    count = pbwio__count(r, "number of segments");
    has_markers = pbwio__has_more(r) ? pbwio__count(r, "number of markers") : 0;
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        pbwio__next_row(r, "a segment");
        pbwio__count(r, "number of the segment");
        for (k = 0; k < 2; k++) {
            id[k] = pbwio__count(r, "point number") - r->cloud->base;
        }
        pbwio__next_marker(r, 1, has_markers > 0);
        if (r->status == PBWIO_OK) {
            pbwio__add_element(r, 1, 2, 2, id);
        }
    }
}

/* Points in holes, or in regions, with the attribute and perhaps a bound.  Files may end before. */
static void pbwio__read_seeds(pbwio__reader *r, int regions)
{
    pbwio_cloud *cloud = r->cloud;
    long long count, i;
    double tag = 0;
    int k;
    if (r->status != PBWIO_OK || !pbwio__row_line(r)) {
        return;
    }
    count = pbwio__count(r, regions ? "number of regions" : "number of holes");
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        pbwio_seed seed;
        size_t room = cloud->capacity[PBWIO__OF_SEEDS] / sizeof seed;
        memset(&seed, 0, sizeof seed);
        seed.group = PBW_NONE;
        pbwio__next_row(r, regions ? "a region" : "a hole");
        pbwio__count(r, regions ? "number of the region" : "number of the hole");
        for (k = 0; k < cloud->dim; k++) {
            seed.place[k] = pbwio__token_number(r);
        }
        if (regions) {
            tag = pbwio__token_number(r);
            seed.bound = pbwio__has_more(r) ? pbwio__token_number(r) : 0;
            seed.bound = seed.bound > 0 ? seed.bound : 0;
            if (!(fabs(tag) < 1e18) || tag > floor(tag)) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "the attribute of a region is %g: a whole number is needed", tag);
            }
            seed.group = r->status != PBWIO_OK ? PBW_NONE
                       : pbwio__find_group(r, cloud->dim, (long long)tag, "", 0);
        }
        if (r->status == PBWIO_OK && cloud->seed_count == room
            && !pbwio__fit_cloud(r, PBWIO__OF_SEEDS, &cloud->seeds, room + room / 2 + 16, sizeof seed)) {
            return;
        }
        if (r->status == PBWIO_OK) {
            cloud->seeds[cloud->seed_count++] = seed;
        }
    }
}

/* The first number of a .poly or .smesh file is 0: its points are in the .node file beside it. */
static int pbwio__lacks_points(const pbwio__reader *r)
{
    pbwio__reader ahead = *r;
    pbwio__field field;
    long long count;
    ahead.error = NULL;
    ahead.report_at = NULL;
    return pbwio__row_line(&ahead) && pbwio__next(&ahead, &field) && pbwio__natural(field, &count) && count == 0;
}

/* Points; facets, in the plane segments; holes; regions. */
static void pbwio__read_poly(pbwio__reader *r)
{
    const size_t size = (size_t)(r->end - r->begin);
    long long dim = 0;
    r->budget += size < (size_t)-1 / 64 ? 24 * size : 0;             /* for the triangulation of a facet */
    if (!pbwio__lacks_points(r)) {
        pbwio__reader ahead = *r;
        ahead.error = NULL;
        pbwio__row_line(&ahead);
        pbwio__count(&ahead, "number of points");
        dim = pbwio__count(&ahead, "dimension");
        pbwio__read_node(r);
    } else if (pbwio__has_nodes(r)) {
        pbwio__row_line(r);
    }
    if (r->status == PBWIO_OK && dim == 3 && r->cloud->dim == 2) {
        pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "the facets are in space; read the file with dim 0 or 3");
    }
    if (r->status == PBWIO_OK && r->cloud->dim == 3) {
        pbwio__read_poly_facets(r);
    } else if (r->status == PBWIO_OK) {
        pbwio__read_poly_segments(r);
    }
    pbwio__read_seeds(r, 0);
    pbwio__read_seeds(r, 1);
}

/* ------------------------------------------------------------------------------------------------------
   >>msh          Meshes of Gmsh: .msh, versions 2.2 and 4.1, text and binary.
   In: the reader at the start of the file.  Out: points, elements, and physical groups as groups.
   Holds: of a file without physical groups the entities are the groups.
   ------------------------------------------------------------------------------------------------------ */

typedef struct pbwio__entity { int dim; long long tag, group; } pbwio__entity;   /* its first physical group or 0 */

typedef struct pbwio__msh {
    int version, binary, big;                /* 2 or 4; of numbers; their byte order */
    int physical;                            /* 1: there are physical groups, 0: entities stand for them */
    PBW_ARRAY(pbw_index) of;                 /* the point of a number of the file; PBW_NONE = none */
    PBW_ARRAY(pbwio__entity) entities;       /* sorted by dimension and tag */
} pbwio__msh;

/* The next integer, of 4 or 8 bytes in binary files. */
static long long pbwio__msh_integer(pbwio__reader *r, const pbwio__msh *m, int size)
{
    pbwio__field field;
    long long value = 0;
    int minus;
    double high, low;
    if (m->binary && size == 4) {
        return (long long)pbwio__binary(r, 4, m->big);
    }
    if (m->binary) {
        low = pbwio__binary(r, 5, m->big);
        high = pbwio__binary(r, 5, m->big);
        value = m->big ? (long long)high + (long long)(low < 1e9 ? low : 1e9) * 4294967296
                       : (long long)low + (long long)(high < 1e9 ? high : 1e9) * 4294967296;
        return value;
    }
    if (pbwio__token(r, &field)) {
        minus = field.begin < field.end && *field.begin == '-';
        field.begin += minus;
        if (!pbwio__natural(field, &value)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not an integer", pbwio__show(r, field));
        }
        value = minus ? -value : value;
    }
    return value;
}

static double pbwio__msh_real(pbwio__reader *r, const pbwio__msh *m)
{
    double value = m->binary ? pbwio__binary(r, 7, m->big) : pbwio__token_number(r);
    if (!pbwio__finite(value)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "a coordinate is not a finite number");
        return 0;
    }
    return value;
}

/* Records that the number of the file is that point. */
static void pbwio__msh_number(pbwio__reader *r, pbwio__msh *m, long long number, size_t point)
{
    size_t count = m->of.count;
    if (number < 0 || number > 0x7fffffffffff || r->status != PBWIO_OK) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%lld is not a point number", number);
        return;
    }
    if ((size_t)number >= count) {
        count = (size_t)number + 1 > count + count / 2 ? (size_t)number + 1 : count + count / 2;
        if (!pbwio__fit(r, &m->of.at, &m->of.capacity, count, sizeof *m->of.at)) {
            return;
        }
        while (m->of.count < count) {
            m->of.at[m->of.count++] = PBW_NONE;
        }
    }
    m->of.at[number] = (pbw_index)point;
}

static void pbwio__msh_nodes(pbwio__reader *r, pbwio__msh *m)
{
    long long blocks = 1, count, i, k, in_block, total = 0;
    double row[3];
    int dim = 0, parametric = 0, n;
    if (r->cloud->points != NULL) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "a second section of nodes");
    }
    blocks = m->version == 4 ? pbwio__msh_integer(r, m, 8) : 1;
    count = m->version == 4 ? pbwio__msh_integer(r, m, 8) : pbwio__token_count(r, "number of points");
    if (m->version == 4) {
        pbwio__msh_integer(r, m, 8);                                 /* the least and the greatest number */
        pbwio__msh_integer(r, m, 8);
    }
    pbwio__choose(r, NULL, 3, 3);
    pbwio__reserve(r, (unsigned long long)count, m->binary ? 28 : 8);
    for (i = 0; i < blocks && r->status == PBWIO_OK; i++) {
        in_block = count;
        if (m->version == 4) {
            dim = (int)pbwio__msh_integer(r, m, 4);
            pbwio__msh_integer(r, m, 4);
            parametric = pbwio__msh_integer(r, m, 4) != 0;
            in_block = pbwio__msh_integer(r, m, 8);
            if (in_block < 0 || in_block > count - total || dim < 0 || dim > 3) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "a block of %lld nodes of dimension %d", in_block, dim);
            }
            for (k = 0; k < in_block && r->status == PBWIO_OK; k++) {
                pbwio__msh_number(r, m, pbwio__msh_integer(r, m, 8), (size_t)(total + k));
            }
        }
        for (k = 0; k < in_block && r->status == PBWIO_OK; k++) {
            if (m->version == 2) {
                pbwio__msh_number(r, m, pbwio__msh_integer(r, m, 4), (size_t)k);
            }
            for (n = 0; n < 3; n++) {
                row[n] = pbwio__msh_real(r, m);
            }
            for (n = 0; n < dim && parametric; n++) {
                pbwio__msh_real(r, m);
            }
            pbwio__add_row(r, row);
        }
        total += in_block;
    }
}

/* $PhysicalNames: a count, then "dimension tag "name"" a line. */
static void pbwio__read_names(pbwio__reader *r, pbwio__msh *m)
{
    long long count = pbwio__token_count(r, "number of names"), dim, tag;
    const char *from, *to;
    while (r->status == PBWIO_OK && count-- > 0 && pbwio__row_line(r)) {
        dim = pbwio__count(r, "dimension");
        tag = pbwio__count(r, "physical group");
        from = (const char *)memchr(r->cursor, '"', (size_t)(r->line_end - r->cursor));
        for (to = r->line_end; from != NULL && to > from && to[-1] != '"'; to--) {
        }
        if (r->status != PBWIO_OK || dim > 3 || tag == 0 || from == NULL || to < from + 2) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "a name is not: dimension, tag, \"name\"");
            return;
        }
        m->physical = 1;
        (void)pbwio__find_group(r, (int)dim, tag, from + 1, (size_t)(to - from) - 2);
    }
}

static int pbwio__compare_entities(const void *a, const void *b)
{
    const pbwio__entity *x = (const pbwio__entity *)a, *y = (const pbwio__entity *)b;
    return x->dim != y->dim ? x->dim - y->dim : (x->tag > y->tag) - (x->tag < y->tag);
}

/* $Entities: how many points, curves, surfaces, volumes; each with its tag, its place or box, its physical groups,
   and what bounds it. */
static void pbwio__read_entities(pbwio__reader *r, pbwio__msh *m)
{
    long long count[4], left, k;
    pbwio__entity e;
    for (e.dim = 0; e.dim < 4; e.dim++) {
        count[e.dim] = pbwio__msh_integer(r, m, 8);
    }
    for (e.dim = 0; e.dim < 4 && r->status == PBWIO_OK; e.dim++) {
        while (count[e.dim]-- > 0 && r->status == PBWIO_OK) {
            e.tag = pbwio__msh_integer(r, m, 4);
            for (k = 0; k < (e.dim == 0 ? 3 : 6); k++) {
                pbwio__msh_real(r, m);
            }
            left = pbwio__msh_integer(r, m, 8);
            for (k = e.group = 0; k < left && r->status == PBWIO_OK; k++) {
                const long long tag = pbwio__msh_integer(r, m, 4);   /* negative: turned */
                e.group = e.group == 0 ? (tag < 0 ? -tag : tag) : e.group;
                m->physical = 1;
            }
            if (left > 1) {
                pbwio__report_once(r, PBWIO__OTHER_GROUPS);
            }
            left = e.dim > 0 ? pbwio__msh_integer(r, m, 8) : 0;
            for (k = 0; k < left && r->status == PBWIO_OK; k++) {
                pbwio__msh_integer(r, m, 4);
            }
            if (!PBWIO__PUSH(r, m->entities, e)) {
                return;
            }
        }
    }
    if (m->entities.count > 0) {
        qsort(m->entities.at, m->entities.count, sizeof e, pbwio__compare_entities);
    }
}

/* The physical group that elements of an entity are in; of files without such the entity itself; PBW_NONE: none. */
static pbw_index pbwio__msh_group(pbwio__reader *r, pbwio__msh *m, int dim, long long entity, long long physical)
{
    if (m->version == 4 && m->entities.count > 0) {
        pbwio__entity wanted;
        const pbwio__entity *found;
        wanted.dim = dim;
        wanted.tag = entity;
        found = (const pbwio__entity *)bsearch(&wanted, m->entities.at, m->entities.count, sizeof wanted,
                                               pbwio__compare_entities);
        physical = found != NULL ? found->group : 0;
    }
    physical = physical < 0 ? -physical : physical;
    if (physical != 0 && !m->physical) {
        m->physical = 1;                                             /* so the entities before were no groups */
        pbwio__clear_groups(r);
    }
    physical = m->physical || dim == 0 ? physical : entity;
    return physical <= 0 || r->status != PBWIO_OK ? PBW_NONE : pbwio__find_group(r, dim, physical, "", 0);
}

/* Of the types of elements of Gmsh: dimension, corners, nodes; solids other than tetrahedra have no corners here. */
static const unsigned char pbwio__shapes[32][3] = {
    { 0, 0, 0 }, { 1, 2, 2 }, { 2, 3, 3 }, { 2, 4, 4 }, { 3, 4, 4 }, { 3, 0, 8 }, { 3, 0, 6 }, { 3, 0, 5 },
    { 1, 2, 3 }, { 2, 3, 6 }, { 2, 4, 9 }, { 3, 4, 10 }, { 3, 0, 27 }, { 3, 0, 18 }, { 3, 0, 14 }, { 0, 1, 1 },
    { 2, 4, 8 }, { 3, 0, 20 }, { 3, 0, 15 }, { 3, 0, 13 }, { 2, 3, 9 }, { 2, 3, 10 }, { 2, 3, 12 }, { 2, 3, 15 },
    { 2, 3, 15 }, { 2, 3, 21 }, { 1, 2, 4 }, { 1, 2, 5 }, { 1, 2, 6 }, { 3, 4, 20 }, { 3, 4, 35 }, { 3, 4, 56 }
};

/* Whether an element is the last of its dimension again, as version 2.2 has those of several physical groups. */
static int pbwio__repeats_last(const pbwio_cloud *cloud, int dim, const long long *id)
{
    const size_t count = dim == 3 ? cloud->tetrahedron_count : dim == 2 ? cloud->triangle_count
                       : cloud->segment_count;
    const pbw_index *last = dim == 3 ? cloud->tetrahedra : dim == 2 ? cloud->triangles : cloud->segments;
    const size_t first = count > 0 ? ((size_t)dim + 1) * (count - 1) : 0;
    size_t k = 0;
    for (; dim > 0 && count > 0 && k <= (size_t)dim; k++) {
        if ((long long)last[first + k] != id[k]) {
            return 0;
        }
    }
    return k > 0;
}

/* One element of a type; those of unknown types, of text files, are passed over. */
static void pbwio__msh_element(pbwio__reader *r, const pbwio__msh *m, long long type)
{
    const unsigned char *shape = pbwio__shapes[type > 0 && type < 32 ? type : 0];
    long long id[56], number;
    int k;
    for (k = 0; k < shape[2] && r->status == PBWIO_OK; k++) {
        number = pbwio__msh_integer(r, m, m->version == 4 ? 8 : 4);
        id[k] = number >= 0 && (unsigned long long)number < m->of.count && m->of.at[number] != PBW_NONE
              ? (long long)m->of.at[number] : -1;
    }
    if (r->status == PBWIO_OK && shape[1] == 0) {
        pbwio__report_once(r, PBWIO__OTHER_SOLIDS);
    } else if (r->status == PBWIO_OK && m->version == 2 && shape[1] < 4 + (shape[0] == 3)
               && pbwio__repeats_last(r->cloud, shape[0], id)) {
        pbwio__report_once(r, PBWIO__OTHER_GROUPS);
    } else if (r->status == PBWIO_OK) {
        pbwio__add_element(r, shape[0], shape[1], shape[2], id);
    }
    if (!m->binary) {
        r->cursor = r->line_end;                                     /* what is not known of the line */
    }
}

/* Version 4: blocks of elements of an entity and a type; version 2: elements, in binary files blocks of a type. */
static void pbwio__msh_elements(pbwio__reader *r, pbwio__msh *m)
{
    const int blocks = m->version == 4 || m->binary;
    long long count = m->version == 4 ? pbwio__msh_integer(r, m, 8) : 0, total, type = 0, tags = 0, in_block, k, i;
    long long dim = 0, tag[2] = { 0, 0 }, value;
    total = m->version == 4 ? pbwio__msh_integer(r, m, 8) : pbwio__token_count(r, "number of elements");
    if (m->version == 4) {
        pbwio__msh_integer(r, m, 8);
        pbwio__msh_integer(r, m, 8);
    }
    for (; (m->version == 4 ? count-- > 0 : total > 0) && r->status == PBWIO_OK; total -= in_block) {
        in_block = 1;
        if (m->version == 4) {
            dim = pbwio__msh_integer(r, m, 4);
            tag[1] = pbwio__msh_integer(r, m, 4);
        }
        if (blocks) {
            type = pbwio__msh_integer(r, m, 4);
            in_block = pbwio__msh_integer(r, m, m->version == 4 ? 8 : 4);
            tags = m->version == 4 ? 0 : pbwio__msh_integer(r, m, 4);
        }
        if (in_block < 0 || in_block > total || tags < 0 || (m->version == 2 && in_block == 0) || dim < 0
            || dim > 3) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "a block of %lld elements, %lld are left", in_block, total);
        }
        for (k = 0; k < in_block && r->status == PBWIO_OK; k++) {
            pbwio__msh_integer(r, m, m->version == 4 ? 8 : 4);       /* its number */
            type = blocks ? type : pbwio__msh_integer(r, m, 4);
            tags = blocks ? tags : pbwio__msh_integer(r, m, 4);
            for (i = 0; i < tags && r->status == PBWIO_OK; i++) {
                value = pbwio__msh_integer(r, m, 4);
                tag[i < 2 ? i : 1] = i < 2 ? value : tag[1];
            }
            if (m->binary && (type <= 0 || type >= 32)) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "elements of type %lld are not read in binary files", type);
            }
            dim = m->version == 4 ? dim : pbwio__shapes[type > 0 && type < 32 ? type : 0][0];
            if (m->version == 2 || k == 0) {
                r->group[dim] = pbwio__msh_group(r, m, (int)dim, tags == 1 ? 0 : tag[1], tags == 0 ? 0 : tag[0]);
            }
            pbwio__msh_element(r, m, type);
        }
    }
}

/* $MeshFormat with "version binary size", in binary files then the integer 1; sections $Name ... $EndName. */
static void pbwio__read_msh(pbwio__reader *r)
{
    static const char end[] = "$End";
    pbwio__field word;
    pbwio__msh m;
    double version;
    memset(&m, 0, sizeof m);
    if (!pbwio__row_line(r) || !pbwio__next(r, &word) || !pbwio__is(word, "$MeshFormat")) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT,
                    "the first line is not \"$MeshFormat\": .msh files of Gmsh are read, others are not");
    }
    version = pbwio__token_number(r);
    m.binary = pbwio__token_number(r) > 0;
    pbwio__token_number(r);
    m.version = version >= 2 && version < 3 ? 2 : version > 4.05 && version < 5 ? 4 : 0;
    if (m.version == 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "version %g: 2.2 and 4.1 are read", version);
    }
    if (m.binary && r->status == PBWIO_OK) {
        m.big = pbwio__binary(r, 4, 0) > 1;
    }
    while (pbwio__row_line(r)) {
        pbwio__next(r, &word);
        if (pbwio__is(word, "$PhysicalNames")) {
            pbwio__read_names(r, &m);
        } else if (pbwio__is(word, "$Nodes") || pbwio__is(word, "$Elements")
                   || (pbwio__is(word, "$Entities") && m.version == 4)) {
            if (m.binary && m.version == 4) {
                r->line_number = 0;
            } else if (m.binary) {
                pbwio__field count;                                  /* a line of text before the numbers */
                pbwio__token(r, &count);
                r->cursor = count.begin;
            }
            if (pbwio__is(word, "$Nodes")) {
                pbwio__msh_nodes(r, &m);
            } else if (pbwio__is(word, "$Entities")) {
                pbwio__read_entities(r, &m);
            } else {
                pbwio__msh_elements(r, &m);
            }
        } else if (word.end - word.begin > 4 && *word.begin == '$' && !pbwio__same(word.begin, 4, end, 4)) {
            if (!pbwio__lists("$Comments $Entities $Periodic $PartitionedEntities", word)) {
                pbwio__report_unread(r, word);
            }
            while (m.binary && r->at < r->end && (r->end - r->at < 4 || memcmp(r->at, end, 4) != 0)) {
                const char *next = (const char *)memchr(r->at + 1, '$', (size_t)(r->end - r->at) - 1);
                r->at = next == NULL ? r->end : next;
            }
        }
    }
    PBWIO__RELEASE(r, m.of);
    PBWIO__RELEASE(r, m.entities);
}

/* ------------------------------------------------------------------------------------------------------
   >>vtu          Meshes of VTK in XML, .vtu: arrays of numbers between tags.
   In: the reader; arrays as text, in base64, or raw behind all tags; plain or in zlib's blocks.
   Out: points, cells as elements, arrays of integers as groups.
   Holds: no array is read beyond its end.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWIO__POINTS, PBWIO__WEIGHTS, PBWIO__MARKERS, PBWIO__CORNERS, PBWIO__ENDS, PBWIO__TYPES, PBWIO__REGIONS,
       PBWIO__PATCHES, PBWIO__CURVES, PBWIO__ARRAYS };

typedef struct pbwio__array {
    int is, type, text, appended;            /* type: out of the table; neither text nor appended: base64 in place */
    int plain;                               /* only the numbers, as text or as they are */
    int components, rank;                    /* rank: of its name, where several will do; the least counts */
    const char *begin, *end;                 /* between its tags */
    double offset;                           /* behind them all */
    pbwio__bytes block;                      /* the decoded bytes, if they are not in the file as they are */
    pbwio__reader values;
} pbwio__array;

typedef struct pbwio__vtu {
    int big, packed, raw;                    /* byte order; zlib; what is appended is not base64 */
    size_t head;                             /* bytes of a length: 4 or 8 */
    double points, cells;
    int type;                                /* of cells without an array of types */
    const char *fields;                      /* where the fields of the whole file start; NULL: none */
    const char *appended;                    /* the first byte behind the underscore; NULL: none */
    pbwio__array array[PBWIO__ARRAYS];
} pbwio__vtu;

/* The value of an attribute of the tag [s, end); an empty field if there is none. */
static pbwio__field pbwio__attribute(const char *s, const char *end, const char *name)
{
    size_t length = strlen(name);
    pbwio__field field;
    const char *stop;
    field.begin = field.end = end;
    for (; s < end && (size_t)(end - s) > length + 2; s++) {
        if ((s[0] == ' ' || s[0] == '\n' || s[0] == '\t' || s[0] == '\r') && memcmp(s + 1, name, length) == 0
            && s[length + 1] == '=' && (s[length + 2] == '"' || s[length + 2] == '\'')) {
            field.begin = s + length + 3;
            stop = (const char *)memchr(field.begin, s[length + 2], (size_t)(end - field.begin));
            field.end = stop == NULL ? field.begin : stop;
            return field;
        }
    }
    return field;
}

static double pbwio__attribute_number(const char *s, const char *end, const char *name)
{
    pbwio__field field = pbwio__attribute(s, end, name);
    double value;
    return pbwio__number(field.begin, field.end, &value) && value >= 0 ? value : 0;
}

/* Arrays of integers that are groups of cells, the first of them that a file has; of cells in the plane patch, of
   lines edge or patch counts more. */
static const char *const pbwio__region_names[] = { "region", "gmsh:physical", "medit:ref", "su2:tag", "material",
    "MaterialIDs", "MaterialID", "CellEntityIds", "CellEntityID", "physical", "attribute", "subdomain", "cell_tags",
    "facet_tags" };

/* The array of that name; NULL: it is not needed. */
static pbwio__array *pbwio__vtu_array_of(pbwio__reader *r, pbwio__vtu *v, const char *section, pbwio__field name,
                                         int *rank)
{
    static const char *const names[] = { "connectivity", "offsets", "types" };
    int k;
    *rank = 0;
    if (strcmp(section, "Points") == 0) {
        return &v->array[PBWIO__POINTS];
    }
    if (strcmp(section, "PointData") == 0) {
        if (r->options->weight != NULL && pbwio__is(name, r->options->weight)) {
            return &v->array[PBWIO__WEIGHTS];
        }
        if (!pbwio__is(name, "marker") && !pbwio__is(name, "id")) {
            pbwio__report_unread(r, name);
        }
        return pbwio__is(name, "marker") ? &v->array[PBWIO__MARKERS] : NULL;
    }
    for (k = 0; k < 3 && strcmp(section, "Cells") == 0; k++) {
        if (pbwio__is(name, names[k])) {
            return &v->array[PBWIO__CORNERS + k];
        }
    }
    if (strcmp(section, "CellData") != 0) {
        return NULL;
    }
    for (k = 0; k < (int)(sizeof pbwio__region_names / sizeof pbwio__region_names[0]); k++) {
        if (pbwio__is(name, pbwio__region_names[k])) {
            *rank = k;
            return &v->array[PBWIO__REGIONS];
        }
    }
    if (!pbwio__lists("patch edge quality", name)) {
        pbwio__report_unread(r, name);
    }
    return pbwio__is(name, "patch") ? &v->array[PBWIO__PATCHES]
         : pbwio__is(name, "edge") ? &v->array[PBWIO__CURVES] : NULL;
}

/* Fills in an array: the tag is [s, end), its content starts behind end.  Returns whether its type is known. */
static int pbwio__vtu_describe(pbwio__reader *r, pbwio__array *a, const char *s, const char *end)
{
    pbwio__field type = pbwio__attribute(s, end, "type"), format = pbwio__attribute(s, end, "format");
    const char *stop;
    int k;
    for (k = 0; k < 10 && !pbwio__is(type, pbwio__types[k].name); k++) {
    }
    memset(a, 0, sizeof *a);
    a->is = 1;
    a->type = k;
    a->text = pbwio__is(format, "ascii");
    a->appended = pbwio__is(format, "appended");
    a->offset = pbwio__attribute_number(s, end, "offset");
    a->components = (int)fmin(pbwio__attribute_number(s, end, "NumberOfComponents"), 1000);
    a->begin = end < r->end ? end + 1 : end;
    stop = (const char *)memchr(a->begin, '<', (size_t)(r->end - a->begin));
    a->end = stop == NULL ? r->end : stop;
    return k < 10;
}

/* Records an array that is needed. */
static void pbwio__vtu_array(pbwio__reader *r, pbwio__vtu *v, const char *section, const char *s, const char *end)
{
    const pbwio__field name = pbwio__attribute(s, end, "Name");
    pbwio__array *a, found;
    int rank, known, groups;
    a = pbwio__vtu_array_of(r, v, section, name, &rank);
    if (a == NULL) {
        return;
    }
    known = pbwio__vtu_describe(r, &found, s, end);
    found.rank = rank;
    groups = a == &v->array[PBWIO__MARKERS] || a >= &v->array[PBWIO__REGIONS];
    if (groups && (!known || found.type == 6 || found.type == 7 || found.components > 1
                   || (a->is && a->rank <= rank))) {
        pbwio__report_unread(r, name);
        return;                                                      /* no numbers of groups, or others count more */
    }
    if ((a->is && !groups) || !known) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "array \"%s\" comes twice, or its type is unknown", pbwio__show(r, name));
        return;
    }
    *a = found;
}

/* Goes through all tags. */
static void pbwio__vtu_tags(pbwio__reader *r, pbwio__vtu *v)
{
    static const char *const sections[] = { "PointData", "CellData", "Points", "Cells", "FieldData", "" };
    const char *section = "", *s = r->at, *end;
    int pieces = 0, k;
    while (r->status == PBWIO_OK && (s = (const char *)memchr(s, '<', (size_t)(r->end - s))) != NULL) {
        pbwio__field name;
        r->at = s++;
        end = (const char *)memchr(s, '>', (size_t)(r->end - s));
        end = end == NULL ? r->end : end;
        name.begin = s;
        for (name.end = s; name.end < end && !pbwio__blank(r, *name.end); name.end++) {
        }
        for (k = 0; k < 5; k++) {
            section = pbwio__is(name, sections[k]) ? sections[k] : section;
        }
        v->fields = pbwio__is(name, "FieldData") ? end : v->fields;
        if (pbwio__is(name, "VTKFile")) {
            pbwio__field packed = pbwio__attribute(s, end, "compressor");
            v->big = pbwio__is(pbwio__attribute(s, end, "byte_order"), "BigEndian");
            v->head = pbwio__is(pbwio__attribute(s, end, "header_type"), "UInt64") ? 8 : 4;
            v->packed = pbwio__is(packed, "vtkZLibDataCompressor");
            if (!pbwio__is(pbwio__attribute(s, end, "type"), "UnstructuredGrid")
                || (packed.begin < packed.end && !v->packed)) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "unstructured grids are read, plain or compressed by zlib; other "
                            "data of VTK: save them as such, or as .vtk or .ply");
            }
        } else if (pbwio__is(name, "Piece")) {
            v->points = pbwio__attribute_number(s, end, "NumberOfPoints");
            v->cells = pbwio__attribute_number(s, end, "NumberOfCells");
            if (pieces++ > 0) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "files of one piece are read");
            }
        } else if (pbwio__is(name, "DataArray")) {
            pbwio__vtu_array(r, v, section, s, end);
        } else if (pbwio__is(name, "AppendedData")) {
            v->raw = pbwio__is(pbwio__attribute(s, end, "encoding"), "raw");
            v->appended = (const char *)memchr(end, '_', (size_t)(r->end - end));
            v->appended = v->appended == NULL ? r->end : v->appended + 1;
            return;                                                  /* what follows may have any bytes */
        }
        s = end;
    }
}

/* Decodes the next count bytes of base64, which end with a group of four letters.  Returns whether they are there. */
static int pbwio__base64(const char **at, const char *end, unsigned char *out, size_t count)
{
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    unsigned char value[256];
    unsigned long group = 0;
    size_t i, done = 0;
    int have = 0, c;
    memset(value, 255, sizeof value);
    for (i = 0; i < 64; i++) {
        value[(unsigned char)letters[i]] = (unsigned char)i;
    }
    for (; done < count && *at < end; (*at)++) {
        c = (unsigned char)**at;
        if (c == ' ' || c == '\n' || c == '\r' || c == '\t') {
            continue;
        }
        if (value[c] == 255 && c != '=') {
            return 0;
        }
        group = group << 6 | (c == '=' ? 0 : value[c]);
        if (++have == 4) {
            for (have = 0; have < 3 && done < count; have++) {
                out[done++] = (unsigned char)(group >> (16 - 8 * have) & 255);
            }
            have = 0;
        }
    }
    return done == count;
}

static void pbwio__vtu_close(pbwio__reader *r, pbwio__bytes *block)
{
    PBW_RELEASE(&r->cloud->memory, *block);
}

/* Bytes of the array at *at, plain or out of base64, into a block that the array then has. */
static const char *pbwio__vtu_bytes(pbwio__reader *r, const pbwio__vtu *v, pbwio__array *a, const char **at,
                                    size_t count)
{
    const char *end = a->appended ? r->end : a->end, *bytes = *at;
    int raw = a->appended && v->raw;
    if (count > (size_t)(end - *at)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "an array of %zu bytes, %zu are left", count, (size_t)(end - *at));
        return NULL;
    }
    if (raw) {
        *at += count;
        return bytes;
    }
    pbwio__vtu_close(r, &a->block);
    if (pbwio__fit(r, &a->block.at, &a->block.capacity, count + 1, 1)) {
        if (!pbwio__base64(at, end, (unsigned char *)a->block.at, count)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the base64 code ends too early");
        }
        r->held -= count + 1;                                        /* it does not count in the budget */
    }
    return r->status == PBWIO_OK ? a->block.at : NULL;
}

/* A length, of 4 or 8 bytes. */
static size_t pbwio__vtu_length(const pbwio__vtu *v, const char *s)
{
    uint64_t value = 0;
    size_t i;
    for (i = 0; i < v->head; i++) {
        value |= (uint64_t)(unsigned char)s[v->big ? v->head - 1 - i : i] << (8 * i);
    }
    return value > (size_t)-1 / 4 ? (size_t)-1 / 4 : (size_t)value;
}

/* Unpacks the blocks at `in`, whose packed sizes follow each other in head from its fourth entry on. */
static void pbwio__vtu_unpack(pbwio__reader *r, const pbwio__vtu *v, pbwio__array *a, const char *head,
                              const char *in)
{
    size_t blocks = pbwio__vtu_length(v, head), size = pbwio__vtu_length(v, head + v->head), i;
    size_t last = pbwio__vtu_length(v, head + 2 * v->head), packed = 0, total, length;
    pbwio__bytes out = { NULL, 0, 0 };
    pbwio__inflater *z;
    for (i = 0; i < blocks; i++) {
        packed += pbwio__vtu_length(v, head + (3 + i) * v->head);
    }
    total = blocks == 0 ? 0 : (last != 0 ? last : size);
    if (blocks > 1 && size > (packed * 1032 + 64) / (blocks - 1)) {
        total = (size_t)-1;
    } else if (blocks > 1) {
        total += (blocks - 1) * size;
    }
    if (total > packed * 1032 + 64) {                                /* Deflate packs no better than that */
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the compressed data are damaged");
        return;
    }
    r->budget += 8 * total;                                          /* the size of the file counts unpacked */
    z = (pbwio__inflater *)pbwio__structure(r, sizeof *z);
    if (z != NULL) {
        z->failed = !pbwio__fit(r, &out.at, &out.capacity, total + 1, 1);
        z->out = (unsigned char *)out.at;
        z->build = r->options->build;
        for (i = 0; i < blocks && !z->failed; i++, in += length) {
            length = pbwio__vtu_length(v, head + (3 + i) * v->head);
            z->in = (const unsigned char *)in + 2;                   /* behind zlib's header */
            z->end = (const unsigned char *)in + length;
            z->capacity = i + 1 < blocks ? z->used + size : total;
            z->failed |= length < 6;
            if (!z->failed) {
                pbwio__inflate(z);
            }
            z->failed |= z->used != z->capacity;
        }
        r->held -= out.capacity;
        pbwio__vtu_close(r, &a->block);
        a->block = out;
        if (z->failed) {
            pbwio__fail(r, z->status != PBWIO_OK ? z->status : PBWIO_ERROR_FORMAT, "%s",
                        z->status != PBWIO_OK ? "cancelled" : "the compressed data are damaged");
        }
        a->values.begin = a->values.at = a->block.at;
        a->values.end = a->block.at == NULL ? NULL : a->block.at + total;
        (void)pbw_memory_resize(&r->cloud->memory, z, 1, 0, sizeof *z);
    }
}

/* Makes the values of an array ready to be read one after the other. */
static void pbwio__vtu_open(pbwio__reader *r, const pbwio__vtu *v, pbwio__array *a)
{
    const char *at = a->appended ? v->appended : a->begin, *from, *bytes, *head;
    size_t length, count;
    pbwio__bytes kept;
    a->values = *r;
    a->values.line_number = 0;
    a->values.line = a->values.line_end = a->values.cursor = a->values.at = at;
    a->values.end = a->end;
    a->values.report_at = NULL;
    if (a->text || a->plain || r->status != PBWIO_OK) {
        return;
    }
    if (at == NULL || a->offset > (double)(r->end - at) || (!a->appended && a->offset > 0)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "an array without data");
        return;
    }
    at += a->appended ? (size_t)a->offset : 0;
    for (from = at; !v->raw || !a->appended;) {                      /* blanks before base64 */
        if (from == r->end || !pbwio__blank(r, *from)) {
            at = from;
            break;
        }
        from++;
    }
    from = at;
    bytes = pbwio__vtu_bytes(r, v, a, &at, v->head);
    if (bytes == NULL) {
        return;
    }
    length = pbwio__vtu_length(v, bytes);
    at = from;
    if (!v->packed) {
        bytes = length < (size_t)(r->end - from) ? pbwio__vtu_bytes(r, v, a, &at, v->head + length) : NULL;
        if (bytes == NULL) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "an array of %zu bytes, %zu are left", length,
                        (size_t)(r->end - from));
            return;
        }
        a->values.begin = bytes;
        a->values.at = bytes + v->head;
        a->values.end = bytes + v->head + length;
        return;
    }
    count = length < (size_t)(r->end - from) ? (3 + length) * v->head : (size_t)-1 / 2;
    head = pbwio__vtu_bytes(r, v, a, &at, count);
    if (head == NULL) {
        return;
    }
    for (count = 0, bytes = head; count < length; count++) {
        size_t part = pbwio__vtu_length(v, head + (3 + count) * v->head);
        bytes = bytes != NULL && part <= (size_t)(r->end - from) ? head : NULL;
    }
    for (count = 0; bytes != NULL && length > 0; length--) {
        count += pbwio__vtu_length(v, head + (2 + length) * v->head);
    }
    kept = a->block;
    memset(&a->block, 0, sizeof a->block);                           /* the head stays while the rest is decoded */
    bytes = bytes != NULL ? pbwio__vtu_bytes(r, v, a, &at, count) : NULL;
    if (bytes != NULL) {
        pbwio__vtu_unpack(r, v, a, head, bytes);
    } else {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the compressed data are damaged");
    }
    pbwio__vtu_close(r, &kept);
}

static double pbwio__vtu_value(pbwio__reader *r, const pbwio__vtu *v, pbwio__array *a)
{
    double value = a->text ? pbwio__token_number(&a->values) : pbwio__binary(&a->values, a->type, v->big);
    if (a->values.status != PBWIO_OK && r->status == PBWIO_OK) {
        r->status = a->values.status;
    } else if (!pbwio__finite(value)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "a value is not a finite number");
    }
    return r->status == PBWIO_OK ? value : 0;
}

/* The group of a dimension and a tag; tag 0: none. */
static pbw_index pbwio__vtu_group(pbwio__reader *r, int dim, double tag)
{
    if (fabs(tag) > 9e15) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%.0f is no number of a group", tag);
    }
    return r->status != PBWIO_OK || !(fabs(tag) > 0) ? PBW_NONE : pbwio__find_group(r, dim, (long long)tag, "", 0);
}

/* A name in XML, with its entities replaced, in place. */
static size_t pbwio__unescape(char *text, size_t length)
{
    static const char *const names[] = { "amp;", "lt;", "gt;", "quot;", "apos;" };
    size_t from = 0, to = 0, n;
    int k;
    text[length] = 0;
    while (from < length) {
        text[to] = text[from++];
        for (k = 0; k < 5 && text[to] == '&'; k++) {
            n = strlen(names[k]);
            if (strncmp(text + from, names[k], n) == 0) {
                text[to] = "&<>\"'"[k];
                from += n;
                break;
            }
        }
        if (k == 5 && text[to] == '&' && text[from] == '#') {
            char *end;
            const int hexadecimal = text[from + 1] == 'x';
            const long code = strtol(text + from + 1 + hexadecimal, &end, hexadecimal ? 16 : 10);
            if (*end == ';' && code > 0 && code < 128) {
                text[to] = (char)code;
                from = (size_t)(end - text) + 1;
            }
        }
        to++;
    }
    return to;
}

/* Groups by name: fields of the whole file with a tag and a dimension. */
static void pbwio__vtu_names(pbwio__reader *r, const pbwio__vtu *v)
{
    const char *s = v->fields, *end, *stop = v->appended != NULL ? v->appended : r->end;
    while (r->status == PBWIO_OK && s != NULL && s < stop
           && (s = (const char *)memchr(s, '<', (size_t)(stop - s))) != NULL) {
        pbwio__field name;
        pbwio__array a;
        double value[2] = { 0, 0 };
        char *copy;
        size_t length;
        s++;
        end = (const char *)memchr(s, '>', (size_t)(stop - s));
        if (end == NULL || (size_t)(end - s) < 9 || memcmp(s, "/FieldData", 9) == 0) {
            return;
        }
        if (memcmp(s, "DataArray", 9) != 0) {
            continue;
        }
        name = pbwio__attribute(s, end, "Name");
        if (name.end == name.begin || !pbwio__vtu_describe(r, &a, s, end) || a.type == 6 || a.type == 7
            || fabs(pbwio__attribute_number(s, end, "NumberOfTuples") * fmax(a.components, 1) - 2) > 0) {
            continue;
        }
        pbwio__vtu_open(r, v, &a);
        value[0] = pbwio__vtu_value(r, v, &a);
        value[1] = pbwio__vtu_value(r, v, &a);
        pbwio__vtu_close(r, &a.block);
        copy = pbwio__copy(r, name.begin, (size_t)(name.end - name.begin));
        length = copy != NULL ? strlen(copy) : 0;
        if (copy != NULL && r->status == PBWIO_OK && fabs(value[0]) > 0 && fabs(value[0]) < 9e15 && value[1] >= 0
            && value[1] <= 3) {
            (void)pbwio__find_group(r, (int)value[1], (long long)value[0], copy, pbwio__unescape(copy, length));
        }
        pbwio__release(r, copy, length + 1, 1);
    }
}

/* Reports progress every 4096 values of an array, as these may lie in blocks. */
static void pbwio__vtu_report(pbwio__reader *r, double i, double done)
{
    if (!(fmod(i, 4096) > 0) && pbwio__stops(r->options->build, done)) {
        pbwio__fail(r, PBWIO_CANCELLED, "cancelled");
    }
}

static void pbwio__vtu_points(pbwio__reader *r, pbwio__vtu *v)
{
    pbwio__array *points = &v->array[PBWIO__POINTS], *weights = &v->array[PBWIO__WEIGHTS];
    pbwio__array *markers = &v->array[PBWIO__MARKERS];
    double value[4], row[3], i;
    int k;
    if (!points->is || points->components != 3 || (r->options->weight != NULL && !weights->is)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, points->is && points->components == 3
                    ? "there is no array of that name for weights" : "there are no points of three coordinates");
    }
    pbwio__vtu_open(r, v, points);
    r->at = points->block.at == NULL ? points->values.at : r->at;  /* else they lie in a block, not in the file */
    if (weights->is) {
        pbwio__vtu_open(r, v, weights);
        r->column[3] = 3;
    }
    if (markers->is) {
        pbwio__vtu_open(r, v, markers);
    }
    if (r->status == PBWIO_OK && (points->text || v->points * 3 * (double)pbwio__types[points->type].size
                                  <= (double)(points->values.end - points->values.at))) {
        pbwio__reader *source = &points->values;
        pbwio__reader all = *r;
        all.at = source->at;
        all.end = source->end;
        pbwio__reserve(&all, (unsigned long long)fmin(v->points, 1e18), points->text ? 6 : 3);
        r->status = all.status;
        r->held = all.held;
        r->point_capacity = all.point_capacity;
    } else {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "points: %.0f announced, the array is shorter", v->points);
    }
    for (i = 0; i < v->points && r->status == PBWIO_OK; i++) {
        pbwio__vtu_report(r, i, 0.5 * i / v->points);
        for (k = 0; k < 3; k++) {
            row[k] = pbwio__vtu_value(r, v, points);
        }
        for (k = 0; k < 3; k++) {
            value[k] = r->column[k] >= 0 ? row[r->column[k]] : 0;
        }
        value[3] = weights->is ? pbwio__vtu_value(r, v, weights) : 0;
        pbwio__add_point(r, value);
        if (markers->is) {
            r->group[0] = pbwio__vtu_group(r, 0, pbwio__vtu_value(r, v, markers));
            pbwio__group_point(r, r->cloud->count - 1);
        }
    }
}

/* The dimension of a type of cells of VTK, -1: it is not kept; its corners, 0: all nodes.  The others are in the
   middles of its edges and so on. */
static int pbwio__vtk_shape(int type, int *corners)
{
    static const unsigned char types[][3] = { { 1, 0, 1 }, { 2, 0, 1 }, { 3, 1, 2 }, { 4, 1, 0 }, { 5, 2, 3 },
        { 6, 2, 0 }, { 7, 2, 0 }, { 8, 2, 4 }, { 9, 2, 4 }, { 10, 3, 4 }, { 21, 1, 2 }, { 22, 2, 3 }, { 23, 2, 4 },
        { 24, 3, 4 }, { 28, 2, 4 },
        { 34, 2, 3 }, { 68, 1, 2 }, { 69, 2, 3 }, { 70, 2, 4 }, { 71, 3, 4 } };
    size_t i;
    for (i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (types[i][0] == type) {
            *corners = types[i][2];
            return types[i][1];
        }
    }
    return -1;
}

/* One cell, of nodes that come next in the array. */
static void pbwio__vtu_cell(pbwio__reader *r, pbwio__vtu *v, int type, double nodes)
{
    long long id[56] = { 0 };
    double value, at;
    int corners = 0, k = 0, dim = pbwio__vtk_shape(type, &corners);
    for (at = 0; at < nodes && r->status == PBWIO_OK; at++) {
        value = pbwio__vtu_value(r, v, &v->array[PBWIO__CORNERS]);
        id[k] = value >= 0 && value < (double)r->cloud->count ? (long long)value : -1;
        if (type == 6) {                                             /* a strip of triangles, which turn by turns */
            const long long turned[3] = { id[1], id[0], id[k] };
            id[2] = id[k];
            if (at >= 2) {
                pbwio__add_element(r, 2, 3, 3, fmod(at, 2) > 0 ? turned : id);
                id[0] = id[1];
                id[1] = id[2];
            }
            k = k < 2 ? k + 1 : 2;
            continue;
        }
        if (dim == 2 && corners == 0) {
            pbwio__add_corner(r, value, (long long)r->cloud->count, (long long)at);
        } else if (dim == 1 && corners == 0 && at > 0) {
            pbwio__add_element(r, 1, 2, 2, id);
            id[0] = id[1];
        }
        k += k < 55 && (corners > 0 || k == 0);
    }
    if (dim < 0) {
        pbwio__report_once(r, PBWIO__OTHER_SOLIDS);
    } else if (r->status == PBWIO_OK && corners > 0) {
        if (k < corners) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "a cell of %d nodes where %d are needed", k, corners);
            return;
        }
        if (type == 8) {                                             /* a pixel goes by rows, not around */
            const long long third = id[2];
            id[2] = id[3];
            id[3] = third;
        }
        pbwio__add_element(r, dim, corners, k, id);
    }
}

static void pbwio__vtu_cells(pbwio__reader *r, pbwio__vtu *v)
{
    pbwio__array *ends = &v->array[PBWIO__ENDS], *types = &v->array[PBWIO__TYPES];
    pbwio__array *regions = &v->array[PBWIO__REGIONS], *patches = &v->array[PBWIO__PATCHES];
    pbwio__array *curves = &v->array[PBWIO__CURVES];
    double i, at = 0, end, region, patch, curve;
    int k, type, unused, dim;
    if (!(v->cells > 0) || !v->array[PBWIO__CORNERS].is || (!v->array[PBWIO__CORNERS].plain && !ends->is)
        || (v->type == 0 && !types->is)) {
        return;
    }
    for (k = PBWIO__CORNERS; k < PBWIO__ARRAYS; k++) {
        if (v->array[k].is) {
            pbwio__vtu_open(r, v, &v->array[k]);
        }
    }
    if (ends->is && ends->plain) {
        pbwio__vtu_value(r, v, ends);                                /* offsets start with 0 */
    }
    for (i = 0; i < v->cells && r->status == PBWIO_OK; i++) {
        pbwio__vtu_report(r, i, 0.5 + 0.5 * i / v->cells);
        type = v->type != 0 ? v->type : (int)fmin(fmax(pbwio__vtu_value(r, v, types), 0), 1000);
        end = ends->is ? pbwio__vtu_value(r, v, ends) : at + pbwio__vtu_value(r, v, &v->array[PBWIO__CORNERS]);
        if (end < at) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "offsets that fall");
        }
        region = regions->is ? pbwio__vtu_value(r, v, regions) : 0;
        patch = patches->is ? pbwio__vtu_value(r, v, patches) : 0;
        curve = curves->is ? pbwio__vtu_value(r, v, curves) : 0;
        dim = pbwio__vtk_shape(type, &unused);
        if (dim >= 0) {
            region = dim < 3 && fabs(patch) > 0 ? patch : region;
            r->group[dim] = pbwio__vtu_group(r, dim, dim == 1 && fabs(curve) > 0 ? curve : region);
        }
        pbwio__vtu_cell(r, v, type, end - at);
        at = end;
    }
}

static void pbwio__read_vtu(pbwio__reader *r)
{
    pbwio__vtu *v = (pbwio__vtu *)pbwio__structure(r, sizeof *v);
    const pbwio_options *given = r->options;
    pbwio_options options = *given;          /* without the weight, an array of another name */
    int k;
    if (v == NULL) {
        return;
    }
    options.weight = NULL;
    r->options = &options;
    pbwio__choose(r, NULL, 3, 3);
    r->options = given;
    pbwio__vtu_tags(r, v);
    pbwio__vtu_names(r, v);
    pbwio__vtu_points(r, v);
    pbwio__vtu_cells(r, v);
    for (k = 0; k < PBWIO__ARRAYS; k++) {
        pbwio__vtu_close(r, &v->array[k].block);
    }
    (void)pbw_memory_resize(&r->cloud->memory, v, 1, 0, sizeof *v);
}

/* ------------------------------------------------------------------------------------------------------
   >>vtk          Meshes of VTK's legacy format, .vtk: sections with keywords.
   In: versions 1.0 to 5.1; numbers as text, or binary with the highest byte first.
   Out: the arrays of a .vtu file, of which that reader makes points and cells.
   Holds: a section of unknown length ends the file, and cloud->dropped says so.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWIO__VTK_PARTS = 4 };               /* of PolyData: vertices, lines, polygons, strips of triangles */

typedef struct pbwio__vtk {
    int binary, point_data, parts;           /* point_data: the arrays at hand are of points */
    double rows;                             /* values of those arrays */
    pbwio__array corners[PBWIO__VTK_PARTS], offsets[PBWIO__VTK_PARTS];
    double cells[PBWIO__VTK_PARTS];
    int type[PBWIO__VTK_PARTS];
    pbwio__vtu vtu;
} pbwio__vtk;

/* The next word as a type of the table; -1: bits, -2: strings. */
static int pbwio__vtk_type(pbwio__reader *r)
{
    static const struct { const char *names; int type; } types[] = {
        { "char signed_char vtktypeint8", 0 }, { "unsigned_char vtktypeuint8", 1 }, { "short vtktypeint16", 2 },
        { "unsigned_short vtktypeuint16", 3 }, { "int vtktypeint32 vtkIdType", 4 },
        { "unsigned_int vtktypeuint32", 5 },
        { "float", 6 }, { "double", 7 }, { "long long_long vtktypeint64", 8 },
        { "unsigned_long unsigned_long_long vtktypeuint64", 9 }, { "bit", -1 }, { "string utf8_string variant", -2 }
    };
    pbwio__field word;
    size_t i;
    pbwio__next(r, &word);
    for (i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (pbwio__lists(types[i].names, word)) {
            return types[i].type;
        }
    }
    pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a type", pbwio__show(r, word));
    return 0;
}

/* Skips the numbers that follow; an array for them, if there is one, records where they are. */
static void pbwio__vtk_numbers(pbwio__reader *r, const pbwio__vtk *k, int type, double count, pbwio__array *a)
{
    const char *begin = k->binary ? r->at : r->cursor;
    const double size = type >= 0 ? (double)pbwio__types[type].size : 0.125;
    pbwio__field field;
    double i, bytes = ceil(count * size);
    if (type == -2) {
        pbwio__report_dropped(r, "what is behind an array of strings");
        r->at = r->cursor = r->line_end = r->end;
        return;
    }
    if (k->binary && bytes > (double)(r->end - r->at)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%.0f numbers are announced, %zu bytes follow", count,
                    (size_t)(r->end - r->at));
        return;
    }
    for (i = 0; i < count && !k->binary && pbwio__token(r, &field); i++) {
    }
    if (k->binary) {
        r->at += (size_t)bytes;
        r->line = r->line_end = r->cursor = r->at;
    }
    if (a != NULL && type >= 0) {
        memset(a, 0, sizeof *a);
        a->is = 1;
        a->type = type;
        a->text = !k->binary;
        a->plain = 1;
        a->begin = begin;
        a->end = k->binary ? r->at : r->cursor;
    }
}

/* Whether the next line starts with a word; it is taken then. */
static int pbwio__vtk_takes(pbwio__reader *r, const char *word)
{
    pbwio__reader look = *r;
    pbwio__field field;
    if (pbwio__row_line(&look) && pbwio__next(&look, &field) && pbwio__is(field, word)) {
        r->at = look.at;
        r->line = look.line;
        r->line_end = look.line_end;
        r->cursor = look.cursor;
        r->line_number = look.line_number;
        return 1;
    }
    return 0;
}

/* CELLS or a part of PolyData: counts and corners in one array, or, from version 5 on, offsets and corners. */
static void pbwio__vtk_part(pbwio__reader *r, pbwio__vtk *k, int type)
{
    const double count = (double)pbwio__count(r, "number of cells");
    const double size = (double)pbwio__count(r, "number of numbers");
    const int part = k->parts;
    if (part == PBWIO__VTK_PARTS) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "more than %d sections of cells", PBWIO__VTK_PARTS);
        return;
    }
    k->type[part] = type;
    if (pbwio__vtk_takes(r, "OFFSETS")) {
        pbwio__vtk_numbers(r, k, pbwio__vtk_type(r), count, &k->offsets[part]);
        if (!pbwio__vtk_takes(r, "CONNECTIVITY")) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "offsets without \"CONNECTIVITY\"");
            return;
        }
        pbwio__vtk_numbers(r, k, pbwio__vtk_type(r), size, &k->corners[part]);
        k->cells[part] = count - 1;
    } else {
        pbwio__vtk_numbers(r, k, 4, size, &k->corners[part]);
        k->cells[part] = count;
    }
    k->parts += k->cells[part] > 0;
}

/* An array of values at points or cells. */
static void pbwio__vtk_values(pbwio__reader *r, pbwio__vtk *k, pbwio__field name, int type, double components,
                              double count)
{
    pbwio__array *a, found;
    int rank;
    if (components > 1) {
        pbwio__report_unread(r, name);
    }
    a = components > 1 ? NULL
      : pbwio__vtu_array_of(r, &k->vtu, k->point_data ? "PointData" : "CellData", name, &rank);
    if (a != NULL && a != &k->vtu.array[PBWIO__WEIGHTS]
        && (type == 6 || type == 7 || type < 0 || (a->is && a->rank <= rank))) {
        pbwio__report_unread(r, name);
        a = NULL;                                                    /* no numbers of groups, or others count more */
    }
    pbwio__vtk_numbers(r, k, type, components * count, &found);
    if (a != NULL && r->status == PBWIO_OK && type >= 0) {
        *a = found;
        a->rank = rank;
    }
}

/* FIELD name count, then for each array name, components, rows, type. */
static void pbwio__vtk_field(pbwio__reader *r, pbwio__vtk *k)
{
    pbwio__field name;
    long long count, i, components, rows;
    pbwio__next(r, &name);
    count = pbwio__count(r, "number of arrays");
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        if (pbwio__vtk_takes(r, "METADATA")) {
            while (pbwio__line(r) && r->line < r->line_end) {
            }
            i--;
            continue;
        }
        pbwio__token(r, &name);
        components = pbwio__count(r, "number of components");
        rows = pbwio__count(r, "number of rows");
        pbwio__vtk_values(r, k, name, pbwio__vtk_type(r), (double)components, (double)rows);
    }
}

/* A keyword of attributes; returns whether it is one. */
static int pbwio__vtk_attribute(pbwio__reader *r, pbwio__vtk *k, pbwio__field word)
{
    static const struct { const char *words; int components; } types[] = {
        { "VECTORS NORMALS", 3 }, { "TENSORS", 9 }, { "TENSORS6", 6 }, { "GLOBAL_IDS PEDIGREE_IDS EDGE_FLAGS", 1 }
    };
    const int scalars = pbwio__is(word, "SCALARS");
    pbwio__field name, number;
    long long components = 1;
    size_t i;
    int type;
    if (scalars || pbwio__is(word, "TEXTURE_COORDINATES") || pbwio__is(word, "LOOKUP_TABLE")
        || pbwio__is(word, "COLOR_SCALARS")) {
        pbwio__next(r, &name);
        if (scalars) {
            type = pbwio__vtk_type(r);
            components = pbwio__next(r, &number) && pbwio__natural(number, &components) ? components : 1;
            pbwio__vtk_takes(r, "LOOKUP_TABLE");
            r->cursor = r->line_end;                                 /* its name */
            pbwio__vtk_values(r, k, name, type, (double)components, k->rows);
            return 1;
        }
        components = pbwio__count(r, "number");
        type = pbwio__is(word, "TEXTURE_COORDINATES") ? pbwio__vtk_type(r) : 1;
        pbwio__vtk_numbers(r, k, type, pbwio__is(word, "LOOKUP_TABLE") ? 4 * (double)components
                           : (double)components * k->rows, NULL);
        return 1;
    }
    for (i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (pbwio__lists(types[i].words, word)) {
            pbwio__next(r, &name);
            pbwio__vtk_values(r, k, name, pbwio__vtk_type(r), types[i].components, k->rows);
            return 1;
        }
    }
    return 0;
}

/* A section that starts with a word. */
static void pbwio__vtk_section(pbwio__reader *r, pbwio__vtk *k, pbwio__field word)
{
    static const char *const parts[] = { "VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS", "CELLS" };
    static const int types[] = { 2, 4, 7, 6, 0 };
    pbwio__field name;
    int i;
    for (i = 0; i < 5; i++) {
        if (pbwio__is(word, parts[i])) {
            pbwio__vtk_part(r, k, types[i]);
            return;
        }
    }
    if (pbwio__is(word, "DATASET")) {
        pbwio__next(r, &name);
        if (!pbwio__is(name, "UNSTRUCTURED_GRID") && !pbwio__is(name, "POLYDATA")) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "data sets UNSTRUCTURED_GRID and POLYDATA are read, \"%s\" is not",
                        pbwio__show(r, name));
        }
    } else if (pbwio__is(word, "POINTS")) {
        k->vtu.points = (double)pbwio__count(r, "number of points");
        pbwio__vtk_numbers(r, k, pbwio__vtk_type(r), 3 * k->vtu.points, &k->vtu.array[PBWIO__POINTS]);
        k->vtu.array[PBWIO__POINTS].components = 3;
    } else if (pbwio__is(word, "CELL_TYPES")) {
        pbwio__vtk_numbers(r, k, 4, (double)pbwio__count(r, "number of cells"), &k->vtu.array[PBWIO__TYPES]);
    } else if (pbwio__is(word, "POINT_DATA") || pbwio__is(word, "CELL_DATA")) {
        k->point_data = pbwio__is(word, "POINT_DATA");
        k->rows = (double)pbwio__count(r, "number of values");
    } else if (pbwio__is(word, "METADATA")) {
        while (pbwio__line(r) && r->line < r->line_end) {
        }
    } else if (pbwio__is(word, "FIELD")) {
        pbwio__vtk_field(r, k);
    } else if (!pbwio__vtk_attribute(r, k, word)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is no section of .vtk", pbwio__show(r, word));
    }
}

/* Makes points and cells of the arrays. */
static void pbwio__vtk_make(pbwio__reader *r, pbwio__vtk *k)
{
    pbwio__vtu *v = &k->vtu;
    const char *weight = r->options->weight;
    const pbwio_options *given = r->options;
    pbwio_options options = *given;
    int i;
    options.weight = NULL;
    r->options = &options;
    r->line_number = 0;
    pbwio__choose(r, NULL, 3, 3);
    options.weight = weight;
    pbwio__vtu_points(r, v);
    for (i = 0; i < k->parts && r->status == PBWIO_OK; i++) {
        v->array[PBWIO__CORNERS] = k->corners[i];
        v->array[PBWIO__ENDS] = k->offsets[i];
        v->type = k->type[i];
        v->cells = k->cells[i];
        if (k->parts > 1 && v->array[PBWIO__REGIONS].is) {           /* it goes on through all parts */
            v->array[PBWIO__REGIONS].is = 0;
            pbwio__report_dropped(r, "the regions of points, lines and polygons in one file");
        }
        pbwio__vtu_cells(r, v);
    }
    r->options = given;
}

static void pbwio__read_vtk(pbwio__reader *r)
{
    pbwio__vtk *k = (pbwio__vtk *)pbwio__structure(r, sizeof *k);
    pbwio__field word;
    if (k == NULL) {
        return;
    }
    k->vtu.big = 1;
    if (r->end - r->at < 5 || memcmp(r->at, "# vtk", 5) != 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the first line is not \"# vtk DataFile Version\"");
    }
    if (!pbwio__line(r) || !pbwio__line(r) || !pbwio__row_line(r) || !pbwio__next(r, &word)
        || (!pbwio__is(word, "ASCII") && !pbwio__is(word, "BINARY"))) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the third line is not \"ASCII\" or \"BINARY\"");
    }
    k->binary = r->status == PBWIO_OK && pbwio__is(word, "BINARY");
    while (r->status == PBWIO_OK && (pbwio__next(r, &word) || pbwio__row_line(r))) {
        if (word.begin < word.end) {
            pbwio__vtk_section(r, k, word);
        }
    }
    if (r->status == PBWIO_OK) {
        pbwio__vtk_make(r, k);
    }
    (void)pbw_memory_resize(&r->cloud->memory, k, 1, 0, sizeof *k);
}

/* ------------------------------------------------------------------------------------------------------
   >>inp          Meshes of Abaqus, .inp: nodes and elements by numbers.
   In: keywords in any case, with lines that go on after a comma; pass 1 reads nodes, pass 2 elements (pass 0 counts
   nodes, pass 3 reads sets).  Out: points and elements; lists of their numbers.
   Holds: a list is sorted before it is searched, and no number is in it twice.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWIO__KEY_TYPE, PBWIO__KEY_ELSET, PBWIO__KEY_NSET, PBWIO__KEY_NAME, PBWIO__KEY_INPUT, PBWIO__KEY_SYSTEM,
       PBWIO__KEY_INSTANCE, PBWIO__KEY_GENERATE, PBWIO__KEY_INTERNAL, PBWIO__KEYS };

typedef struct pbwio__numbered {             /* the points or elements of a number of the file */
    long long number;
    pbw_index first;                         /* the first of its points or elements in the cloud */
    unsigned char count, dim, corners, shell;        /* count: how many those are, 0: it is passed over */
} pbwio__numbered;

typedef struct pbwio__index { PBW_ARRAY(pbwio__numbered) list; int sorted; } pbwio__index;

typedef struct pbwio__member {               /* of a set: numbers from first to last in steps, on that side */
    long long first, last;
    pbw_index step, next;                    /* next: the following one of its set */
    int side;                                /* S1 and so on are 1 to 6, E1 and so on 11 to 14; 0: the whole */
} pbwio__member;

typedef struct pbwio__set {
    pbwio__field name;
    int kind;                                /* 'n' of nodes, 'e' of elements, 's' a surface */
    int section, of_surface, internal;       /* a section names it; a surface is made of it; a program's own */
    pbw_index first, last;                   /* its members, PBW_NONE: none */
    size_t size;                             /* of its elements of the dimension at hand */
    int whole;                               /* those are all that there are */
    pbw_index group;
} pbwio__set;

typedef struct pbwio__inp {
    char word[32];                           /* the keyword at hand, small letters without blanks */
    pbwio__field value[PBWIO__KEYS];         /* of its parameters; begin NULL: it has none of that name */
    int rows;                                /* what its rows are: 'p' nodes, 'c' elements, sets as above, 'i', 0 */
    int coordinates, parts, instances, assembly;
    int of_assembly;                         /* rows are numbers of the assembly's own */
    int dim, corners, nodes, shell;          /* of elements of the type at hand */
    pbw_index set;                           /* that the rows belong to */
    pbwio__index points, elements;
    PBW_ARRAY(pbwio__member) members;
    PBW_ARRAY(pbwio__set) sets;
    size_t node_count, table_size;
    pbw_index *table;                        /* of sets, by hashes of kinds and names */
    double steps;                            /* members that were looked at */
    uint64_t sum;                            /* of hashes of facets, where two of one facet cancel */
    char lost[120];                          /* names of sets that lost members to others */
} pbwio__inp;

/* ---- lines ---- */

/* Steps to the next line that is neither blank nor a comment. */
static int pbwio__inp_line(pbwio__reader *r)
{
    const char *s;
    while (pbwio__line(r)) {
        for (s = r->line; s < r->line_end && pbwio__blank(r, *s); s++) {
        }
        if (s < r->line_end && (*s != '*' || s + 1 == r->line_end || s[1] != '*')) {
            r->cursor = s;
            return 1;
        }
    }
    return 0;
}

/* Reads the next field; where a line ends with a comma, on the line after it, if that goes on with a letter or, in a
   row, with no keyword. */
static int pbwio__inp_field(pbwio__reader *r, int row, pbwio__field *field)
{
    const char *s;
    if (!pbwio__next(r, field)) {
        return 0;
    }
    for (s = r->at; s < r->end && pbwio__blank(r, *s); s++) {
    }
    if (field->begin == field->end && r->over && s < r->end && *s != '*'
        && (row || (pbwio__lower(*s) >= 'a' && pbwio__lower(*s) <= 'z'))) {
        return pbwio__inp_line(r) && pbwio__next(r, field);
    }
    return field->end > field->begin || !r->over;
}

static pbwio__field pbwio__trim(pbwio__reader *r, const char *begin, const char *end)
{
    pbwio__field field;
    while (begin < end && pbwio__blank(r, *begin)) {
        begin++;
    }
    while (end > begin && pbwio__blank(r, end[-1])) {
        end--;
    }
    if (end - begin >= 2 && *begin == '"' && end[-1] == '"') {
        begin++;
        end--;
    }
    field.begin = begin;
    field.end = end;
    return field;
}

/* Reads a keyword and its parameters. */
static void pbwio__inp_keyword(pbwio__reader *r, pbwio__inp *p)
{
    static const char *const keys[] = { "type", "elset", "nset", "name", "input", "system", "instance", "generate",
                                        "internal" };
    pbwio__field field;
    const char *s;
    size_t used = 0;
    int k;
    memset(p->value, 0, sizeof p->value);
    pbwio__next(r, &field);
    for (s = field.begin + 1; s < field.end && used + 1 < sizeof p->word; s++) {
        if (!pbwio__blank(r, *s)) {
            p->word[used++] = (char)pbwio__lower(*s);
        }
    }
    p->word[used] = 0;
    while (pbwio__inp_field(r, 0, &field)) {
        const char *equal = (const char *)memchr(field.begin, '=', (size_t)(field.end - field.begin));
        const pbwio__field key = pbwio__trim(r, field.begin, equal == NULL ? field.end : equal);
        for (k = 0; k < PBWIO__KEYS; k++) {
            if (pbwio__is(key, keys[k])) {
                p->value[k] = pbwio__trim(r, equal == NULL ? field.end : equal + 1, field.end);
            }
        }
    }
}

/* ---- numbers ---- */

static void pbwio__add_number(pbwio__reader *r, pbwio__index *n, const pbwio__numbered *entry)
{
    const size_t count = n->list.count;
    n->sorted = count == 0 || (n->sorted && n->list.at[count - 1].number < entry->number);
    (void)PBWIO__PUSH(r, n->list, *entry);
}

static int pbwio__compare_numbers(const void *a, const void *b)
{
    const long long x = ((const pbwio__numbered *)a)->number, y = ((const pbwio__numbered *)b)->number;
    return (x > y) - (x < y);
}

/* Puts numbers in order; what: of what, for a message where one comes twice. */
static void pbwio__sort_numbers(pbwio__reader *r, pbwio__index *n, const char *what)
{
    size_t i;
    if (!n->sorted && n->list.count > 0) {
        qsort(n->list.at, n->list.count, sizeof *n->list.at, pbwio__compare_numbers);
    }
    for (i = 1; i < n->list.count && r->status == PBWIO_OK; i++) {
        if (n->list.at[i - 1].number == n->list.at[i].number) {
            r->status = pbwio__file_error(r->error, PBWIO_ERROR_FORMAT, r->name, "%s %lld comes twice", what,
                                          n->list.at[i].number);
        }
    }
}

/* The index of the first number of the list that is not below that one. */
static size_t pbwio__from_number(const pbwio__index *n, long long number)
{
    size_t low = 0, high = n->list.count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (n->list.at[middle].number < number) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

static const pbwio__numbered *pbwio__find_number(const pbwio__index *n, long long number)
{
    const size_t at = pbwio__from_number(n, number);
    return at < n->list.count && n->list.at[at].number == number ? n->list.at + at : NULL;
}

/* ---- nodes and elements ---- */

/* Of a type of elements: dimension, corners, nodes; corners 0: it is passed over. */
static void pbwio__inp_type(pbwio__reader *r, pbwio__inp *p)
{
    static const struct { const char *name; unsigned char dim, shell; } families[] = {
        { "c3d", 3, 0 }, { "cpeg", 2, 0 }, { "cpe", 2, 0 }, { "cps", 2, 0 }, { "cgax", 2, 0 }, { "cax", 2, 0 },
        { "c2d", 2, 0 }, { "stri", 2, 1 }, { "sfm3d", 2, 1 }, { "m3d", 2, 1 }, { "r3d", 2, 1 }, { "ds", 2, 1 },
        { "sax", 1, 0 }, { "s", 2, 1 }, { "t3d", 1, 0 }, { "t2d", 1, 0 }, { "c1d", 1, 0 }, { "r2d", 1, 0 },
        { "rax", 1, 0 }, { "b2", 1, 0 }, { "b3", 1, 0 }
    };
    const pbwio__field type = p->value[PBWIO__KEY_TYPE];
    const char *s = type.begin;
    size_t i, length = 0;
    long digits = 0;
    if (s == NULL || s == type.end) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "*ELEMENT without a TYPE");
        return;
    }
    s += type.end - s > 3 && strchr("dDaA", *s) != NULL && pbwio__lower(s[1]) == 'c';    /* of heat, of sound */
    for (i = 0; i < sizeof families / sizeof families[0]; i++) {
        length = strlen(families[i].name);
        if ((size_t)(type.end - s) > length && pbwio__same(s, length, families[i].name, length)
            && (unsigned)s[length] - '0' <= 9) {
            break;
        }
    }
    p->dim = p->corners = p->nodes = p->shell = 0;
    if (i < sizeof families / sizeof families[0]) {
        for (s += length; s < type.end && (unsigned)*s - '0' <= 9 && digits < 1000; s++) {
            digits = 10 * digits + (*s - '0');
        }
        p->dim = families[i].dim;
        p->shell = families[i].shell;
        p->nodes = (int)(digits == 65 ? 6 : digits);
    }
    if (p->dim == 1) {                                               /* beams and shells of revolution by order */
        p->nodes = families[i].name[0] == 'b' || families[i].name[0] == 's' ? (digits == 2 ? 3 : 2) : p->nodes;
        p->corners = p->nodes == 2 || p->nodes == 3 ? 2 : 0;
    } else if (p->dim == 2) {
        p->corners = p->nodes == 3 || p->nodes == 6 ? 3 : p->nodes == 4 || p->nodes == 8 || p->nodes == 9 ? 4 : 0;
    } else {
        p->corners = p->nodes == 4 || p->nodes == 10 ? 4 : 0;
    }
    if (p->corners == 0 && p->dim == 3) {
        pbwio__report_once(r, PBWIO__OTHER_SOLIDS);
    } else if (p->corners == 0 && strlen(r->cloud->dropped) < 180) {
        char text[64];
        snprintf(text, sizeof text, "elements of type %s", pbwio__show(r, type));
        pbwio__report_once(r, text);
    }
}

static long long pbwio__inp_number(pbwio__reader *r, pbwio__field field, const char *what)
{
    long long number = 0;
    if (!pbwio__natural(field, &number)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a %s", pbwio__show(r, field), what);
    }
    return number;
}

/* A node: its number and its coordinates; those that are left out are 0. */
static void pbwio__inp_node(pbwio__reader *r, pbwio__inp *p)
{
    double row[3] = { 0, 0, 0 };
    pbwio__numbered entry;
    pbwio__field field;
    int k;
    memset(&entry, 0, sizeof entry);
    pbwio__next(r, &field);
    entry.number = pbwio__inp_number(r, field, "node number");
    entry.first = (pbw_index)r->cloud->count;
    entry.count = 1;
    for (k = 0; k < 3 && pbwio__next(r, &field); k++) {
        if (field.end > field.begin && !pbwio__number(field.begin, field.end, row + k)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "coordinate %d, \"%s\", is not a finite number", k + 1,
                        pbwio__show(r, field));
        }
    }
    pbwio__add_row(r, row);
    pbwio__add_number(r, &p->points, &entry);
}

/* An element: its number and its nodes, on several lines where they end with a comma. */
static void pbwio__inp_element(pbwio__reader *r, pbwio__inp *p)
{
    long long id[10] = { 0 };        /* more nodes have only elements that are passed */
    pbwio__numbered entry;
    pbwio__field field;
    int k = 0;
    memset(&entry, 0, sizeof entry);
    pbwio__inp_field(r, 1, &field);
    entry.number = pbwio__inp_number(r, field, "number of an element");
    entry.dim = (unsigned char)p->dim;
    entry.corners = (unsigned char)p->corners;
    entry.shell = (unsigned char)p->shell;
    for (; r->status == PBWIO_OK && (p->nodes == 0 || k < p->nodes) && pbwio__inp_field(r, 1, &field); k++) {
        const long long number = pbwio__inp_number(r, field, "node number");
        const pbwio__numbered *node = pbwio__find_number(&p->points, number);
        if (p->corners > 0 && node == NULL) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "element %lld has node %s, which is not there", entry.number,
                        pbwio__show(r, field));
        } else if (p->corners > 0) {
            id[k] = (long long)node->first;
        }
    }
    if (p->corners > 0 && k < p->nodes) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "element %lld has %d nodes where %d are needed", entry.number, k,
                    p->nodes);
    }
    if (p->dim == 1 && p->nodes == 3) {                              /* end, middle, end */
        const long long middle = id[1];
        id[1] = id[2];
        id[2] = middle;
    }
    if (r->status == PBWIO_OK && p->corners > 0) {
        const pbwio_cloud *cloud = r->cloud;
        entry.first = (pbw_index)(p->dim == 3 ? cloud->tetrahedron_count : p->dim == 2 ? cloud->triangle_count
                                  : cloud->segment_count);
        entry.count = p->dim == 2 ? (unsigned char)(p->corners - 2) : 1;
        pbwio__add_element(r, p->dim, p->corners, p->nodes, id);
    }
    pbwio__add_number(r, &p->elements, &entry);
}

/* ------------------------------------------------------------------------------------------------------
   >>sets         Sets and surfaces of .inp, and all of the file.
   In: rows of sets and surfaces.  Out: groups.
   Holds: members of sets are looked at 16 times a byte of the file at most.

   A set has elements of several dimensions: it is a group of each.  An element in several sets is in one group: of
   1. the last set that a section names,
   2. else the last of the other sets,
   3. else the last of the sets that surfaces are made of, or that have all elements,
   4. else the last surface of shells.
   Sets that lose elements so, and sets of all elements beside others, are reported.
   ------------------------------------------------------------------------------------------------------ */

static uint64_t pbwio__set_hash(int kind, pbwio__field name)
{
    uint64_t h = (uint64_t)kind;
    const char *s;
    for (s = name.begin; s < name.end; s++) {
        h = (h ^ (uint64_t)pbwio__lower((unsigned char)*s)) * 0x100000001b3u;        /* FNV-1a */
    }
    h *= 0x9e3779b97f4a7c15u;
    return h ^ h >> 32;
}

/* Doubles the table of sets. */
static int pbwio__set_table(pbwio__reader *r, pbwio__inp *p)
{
    const size_t size = p->table_size == 0 ? 64 : 2 * p->table_size;
    size_t i, at;
    if (!pbwio__fit(r, &p->table, &p->table_size, size, sizeof *p->table)) {
        return 0;
    }
    memset(p->table, 0xff, size * sizeof *p->table);                 /* PBW_NONE */
    for (i = 0; i < p->sets.count; i++) {
        const pbwio__set *set = p->sets.at + i;
        for (at = (size_t)pbwio__set_hash(set->kind, set->name) & (size - 1); p->table[at] != PBW_NONE;
             at = (at + 1) & (size - 1)) {
        }
        p->table[at] = (pbw_index)i;
    }
    return 1;
}

/* The set of that kind and name, whatever the case of letters; new if there is none and it may be made. */
static pbw_index pbwio__find_set(pbwio__reader *r, pbwio__inp *p, int kind, pbwio__field name, int make)
{
    const size_t length = (size_t)(name.end - name.begin);
    pbwio__set *set, added;
    size_t at;
    if (2 * (p->sets.count + 1) > p->table_size && !pbwio__set_table(r, p)) {
        return PBW_NONE;
    }
    for (at = (size_t)pbwio__set_hash(kind, name) & (p->table_size - 1); p->table[at] != PBW_NONE;
         at = (at + 1) & (p->table_size - 1)) {
        set = p->sets.at + p->table[at];
        if (set->kind == kind && pbwio__same(set->name.begin, (size_t)(set->name.end - set->name.begin), name.begin,
                                             length)) {
            return p->table[at];
        }
    }
    if (!make) {
        return PBW_NONE;
    }
    memset(&added, 0, sizeof added);
    added.name = name;
    added.kind = kind;
    added.first = added.last = PBW_NONE;
    if (!PBWIO__PUSH(r, p->sets, added)) {
        return PBW_NONE;
    }
    p->table[at] = (pbw_index)(p->sets.count - 1);
    return p->table[at];
}

/* Adds numbers to a set; one that follows the last of its numbers only prolongs that. */
static void pbwio__add_member(pbwio__reader *r, pbwio__inp *p, pbw_index s, const pbwio__member *member)
{
    pbwio__set *set = p->sets.at + s;
    pbwio__member *last = set->last != PBW_NONE ? p->members.at + set->last : NULL, added;
    pbw_index at;
    if (last != NULL && last->step == 1 && member->step == 1 && last->side == member->side
        && member->first == last->last + 1) {
        last->last = member->last;
        return;
    }
    added = *member;
    added.next = PBW_NONE;
    if (!PBWIO__PUSH(r, p->members, added)) {
        return;
    }
    at = (pbw_index)(p->members.count - 1);
    if (set->last == PBW_NONE) {
        set->first = at;
    } else {
        p->members.at[set->last].next = at;
    }
    set->last = at;
}

/* Adds the number in a field, or the members so far of the set of that kind that it names, on that side. */
static void pbwio__add_to_set(pbwio__reader *r, pbwio__inp *p, int kind, pbwio__field field, int side)
{
    const pbwio__index *numbers = kind == 'n' ? &p->points : &p->elements;
    pbwio__field rest = field;
    pbwio__member member;
    pbw_index from, at, end;
    const char *s;
    memset(&member, 0, sizeof member);
    from = pbwio__find_set(r, p, kind, field, 0);
    for (s = field.end; s > field.begin && s[-1] != '.'; s--) {      /* behind the name of an instance */
    }
    rest.begin = p->instances > 0 ? s : field.begin;
    from = from == PBW_NONE ? pbwio__find_set(r, p, kind, rest, 0) : from;
    if (from == PBW_NONE && pbwio__natural(rest, &member.first)) {
        if (p->of_assembly && rest.begin == field.begin) {
            return;
        }
        if (pbwio__find_number(numbers, member.first) == NULL) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "a set has %s %lld, which is not there",
                        kind == 'n' ? "node" : "element", member.first);
        }
        member.last = member.first;
        member.step = 1;
        member.side = side;
        pbwio__add_member(r, p, p->set, &member);
        return;
    }
    if (from == PBW_NONE) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is neither a number nor a set so far", pbwio__show(r, field));
        return;
    }
    p->sets.at[from].of_surface |= side != 0;
    end = p->sets.at[from].last;
    for (at = p->sets.at[from].first; at != PBW_NONE && r->status == PBWIO_OK; at = at == end ? PBW_NONE
         : p->members.at[at].next) {
        member = p->members.at[at];
        member.side = side != 0 ? side : member.side;
        pbwio__add_member(r, p, p->set, &member);
    }
}

/* Returns the number of the side of an element that a field names; 0 if it names none. */
static int pbwio__inp_side(pbwio__field field)
{
    const size_t length = (size_t)(field.end - field.begin);
    const int digit = length == 2 ? field.begin[1] - '0' : 0;
    return pbwio__is(field, "SPOS") || pbwio__is(field, "SNEG") || pbwio__is(field, "P") || pbwio__is(field, "N") ? 1
         : digit >= 1 && digit <= 6 && (*field.begin | 32) == 's' ? digit
         : digit >= 1 && digit <= 4 && (*field.begin | 32) == 'e' ? 10 + digit : 0;
}

/* A row of a set: numbers and names; first, last and step of numbers; an element or a set and a side. */
static void pbwio__inp_members(pbwio__reader *r, pbwio__inp *p)
{
    const int kind = p->rows, generated = p->value[PBWIO__KEY_GENERATE].begin != NULL && kind != 's';
    pbwio__field field, side;
    long long range[3] = { 0, 0, 1 };
    pbwio__member member;
    int k = 0;
    while (r->status == PBWIO_OK && pbwio__next(r, &field)) {
        if (field.end == field.begin && kind != 's') {
            continue;
        }
        if (generated && k < 3) {
            range[k++] = pbwio__inp_number(r, field, "number");
        } else if (kind == 's') {
            side.begin = side.end = field.end;
            (void)pbwio__next(r, &side);
            k = pbwio__inp_side(side);
            if (k == 0 || field.end == field.begin) {
                pbwio__report_once(r, "parts of surfaces that name no side of elements");
                return;
            }
            pbwio__add_to_set(r, p, 'e', field, k);
            return;
        } else {
            pbwio__add_to_set(r, p, kind, field, 0);
        }
    }
    if (!generated || r->status != PBWIO_OK || p->of_assembly) {
        return;
    }
    if (k < 2 || range[0] > range[1] || range[2] < 1 || range[2] >= PBW_NONE) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "numbers from %lld to %lld in steps of %lld", range[0], range[1],
                    range[2]);
        return;
    }
    memset(&member, 0, sizeof member);
    member.first = range[0];
    member.last = range[1];
    member.step = (pbw_index)range[2];
    pbwio__add_member(r, p, p->set, &member);
}

/* ---- passes ---- */

/* What makes nodes and elements elsewhere or by rule. */
static void pbwio__inp_refuse(pbwio__reader *r, pbwio__inp *p)
{
    static const char rules[] = "ngen nfill ncopy nmap elgen elcopy elmove";
    const pbwio__field input = p->value[PBWIO__KEY_INPUT], system = p->value[PBWIO__KEY_SYSTEM];
    pbwio__field word;
    word.begin = p->word;
    word.end = p->word + strlen(p->word);
    if (strcmp(p->word, "include") == 0 || (input.begin != NULL && p->rows != 0)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "lines of another file, \"%s\", are not read: put them here",
                    input.begin == NULL ? "" : pbwio__show(r, input));
    } else if (pbwio__lists(rules, word)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "*%s makes nodes or elements by a rule, and is not read: list them",
                    p->word);
    } else if (strcmp(p->word, "system") == 0 || (p->rows == 'p' && system.begin != NULL
                                                  && !pbwio__is(system, "R"))) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "nodes in a coordinate system of their own are not read");
    } else if (p->parts > 1 || p->instances > 1) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "files of one part and one instance are read, this has several: write the "
                    "model without parts and assemblies");
    }
}

/* Updates what follows from a keyword: parts, assemblies, what its rows are. */
static void pbwio__inp_start(pbwio__reader *r, pbwio__inp *p)
{
    static const struct { const char *word; int rows; } words[] = {
        { "node", 'p' }, { "element", 'c' }, { "nset", 'n' }, { "elset", 'e' }, { "surface", 's' },
        { "instance", 'i' }
    };
    static const char passed[] = "heading preprint part endpart endinstance assembly endassembly instance system "
        "nodeoutput";
    pbwio__field word;
    size_t k;
    p->assembly = strcmp(p->word, "assembly") == 0 || (p->assembly && strcmp(p->word, "endassembly") != 0);
    p->parts += strcmp(p->word, "part") == 0;
    p->instances += strcmp(p->word, "instance") == 0;
    p->assembly = strcmp(p->word, "instance") == 0 ? 0 : strcmp(p->word, "endinstance") == 0 ? 1 : p->assembly;
    p->rows = 0;
    for (k = 0; k < sizeof words / sizeof words[0]; k++) {
        p->rows = strcmp(p->word, words[k].word) == 0 ? words[k].rows : p->rows;
    }
    p->of_assembly = p->assembly && p->value[PBWIO__KEY_INSTANCE].begin == NULL;
    if ((p->rows == 'p' || p->rows == 'c') && p->of_assembly) {
        pbwio__report_once(r, "nodes and elements of the assembly");
        p->rows = 0;
    } else if (p->rows == 'n' && p->value[PBWIO__KEY_ELSET].begin != NULL) {
        pbwio__report_once(r, "sets of the nodes of sets of elements");
        p->rows = 0;
    } else if (p->rows == 's' && p->value[PBWIO__KEY_TYPE].begin != NULL
               && !pbwio__is(p->value[PBWIO__KEY_TYPE], "ELEMENT")) {
        pbwio__report_once(r, "surfaces of nodes and other kinds");
        p->rows = 0;
    }
    word.begin = p->word;
    word.end = p->word + strlen(p->word);
    if (p->rows == 0 && !pbwio__lists(passed, word)) {
        pbwio__report_once(r, "what is no node, element, set or surface: materials, sections, steps");
    }
}

/* The set that the rows of a keyword belong to, PBW_NONE: to none; or notes the set that a section names. */
static void pbwio__inp_open_set(pbwio__reader *r, pbwio__inp *p)
{
    const int kind = p->rows == 's' ? 's' : p->rows == 'p' || p->rows == 'n' ? 'n' : 'e';
    const pbwio__field name = p->value[kind == 's' ? PBWIO__KEY_NAME : kind == 'n' ? PBWIO__KEY_NSET
                                       : PBWIO__KEY_ELSET];
    const size_t length = strlen(p->word);
    const int section = length > 7 && strcmp(p->word + length - 7, "section") == 0;
    const pbw_index set = name.begin < name.end && (section || (p->rows != 0 && p->rows != 'i'))
                        ? pbwio__find_set(r, p, kind, name, 1) : PBW_NONE;
    p->set = section ? PBW_NONE : set;
    if (set != PBW_NONE && section) {
        p->sets.at[set].section = 1;
    } else if (set != PBW_NONE && p->value[PBWIO__KEY_INTERNAL].begin != NULL) {
        p->sets.at[set].internal = 1;
    } else if (set == PBW_NONE && strchr("nes", p->rows) != NULL && p->rows != 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "a set without a name");
    }
}

/* One row: 0 counts nodes and their coordinates, 1 reads nodes, 2 elements, 3 sets. */
static void pbwio__inp_row(pbwio__reader *r, pbwio__inp *p, int pass)
{
    pbwio__member member;
    pbwio__field field;
    int k = 0;
    if (pass == 0 && p->rows == 'i') {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "an instance that is moved is not read: write the model without parts and "
                    "assemblies");
    } else if (pass == 0 && p->rows == 'p') {
        while (k < 4 && pbwio__next(r, &field)) {
            k += field.end > field.begin || !r->over;
        }
        p->coordinates = k > p->coordinates + 1 ? k - 1 : p->coordinates;
        p->node_count++;
    } else if (pass == 1 && p->rows == 'p') {
        pbwio__inp_node(r, p);
    } else if (pass == 2 && p->rows == 'c') {
        pbwio__inp_element(r, p);
    } else if (pass == 3 && p->rows != 'p' && p->rows != 'c' && p->rows != 'i') {
        pbwio__inp_members(r, p);
    }
    if (p->set != PBW_NONE && r->status == PBWIO_OK
        && ((pass == 1 && p->rows == 'p') || (pass == 2 && p->rows == 'c'))) {
        const pbwio__index *n = pass == 1 ? &p->points : &p->elements;
        memset(&member, 0, sizeof member);
        member.first = member.last = n->list.at[n->list.count - 1].number;
        member.step = 1;
        pbwio__add_member(r, p, p->set, &member);
    }
}

static void pbwio__inp_pass(pbwio__reader *r, pbwio__inp *p, const char *begin, int pass)
{
    r->at = r->report_at = begin;
    r->pass = pass;
    r->line_number = 0;
    p->rows = p->parts = p->instances = p->assembly = 0;
    while (pbwio__inp_line(r)) {
        if (*r->cursor == '*') {
            pbwio__inp_keyword(r, p);
            pbwio__inp_start(r, p);
            if (pass == 0) {
                pbwio__inp_refuse(r, p);
            }
            if (pass == 2 && p->rows == 'c') {
                pbwio__inp_type(r, p);
            }
            p->set = PBW_NONE;
            if (pass == 3 || (pass == 1 && p->rows == 'p') || (pass == 2 && p->rows == 'c')) {
                pbwio__inp_open_set(r, p);
            }
        } else if (p->rows != 0) {
            pbwio__inp_row(r, p, pass);
        }
    }
}

/* ---- groups ---- */

/* Which side of an element a member of a set means: 0 to 3 a facet, 4 the element, -1 none that is read. */
static int pbwio__side_of(const pbwio__numbered *e, int side)
{
    static const signed char tetrahedron[] = { 3, 2, 0, 1 };         /* S1 is across from the last corner */
    const int edge = side > 10 ? side - 11 : e->shell ? side - 3 : side - 1;
    if (e->corners == 0 || side == 0 || (e->shell && side <= 2)) {
        return e->corners == 0 ? -1 : 4;
    }
    return e->dim == 3 ? (side <= 4 ? tetrahedron[side - 1] : -1)
         : e->dim == 2 && edge >= 0 && edge < e->corners ? edge : -1;
}

/* The corners of a facet of an element. */
static int pbwio__facet_of(const pbwio_cloud *cloud, const pbwio__numbered *e, int side, pbw_index corner[3])
{
    const pbw_index *t = e->dim == 3 ? cloud->tetrahedra + 4 * (size_t)e->first
                       : cloud->triangles + 3 * (size_t)e->first;
    int k;
    for (k = 0; k < 3 && e->dim == 3; k++) {
        corner[k] = t[PBW_FACET_CORNER(side, k)];
    }
    for (k = 0; k < 2 && e->dim == 2; k++) {                         /* of a quadrilateral the second triangle has */
        const int at = (side + k) % e->corners;                      /* the last corner */
        corner[k] = at < 3 ? t[at] : t[5];
    }
    return e->dim;
}

/* A number made of a facet, whatever the order of its corners. */
static uint64_t pbwio__facet_hash(const pbwio_cloud *cloud, const pbwio__numbered *e, int side)
{
    pbw_index corner[3];
    uint64_t sum = 0, h;
    int count = pbwio__facet_of(cloud, e, side, corner);
    while (count-- > 0) {
        h = ((uint64_t)corner[count] + 1) * 0x9e3779b97f4a7c15u;
        sum += (h ^ h >> 29) * 0xbf58476d1ce4e5b9u;
    }
    sum = (sum ^ sum >> 31) * 0x94d049bb133111ebu;
    return sum ^ sum >> 32;
}

/* Puts what a set has into it: points (dim 0), elements of a dimension, triangles (dim 4) or edges (dim 5) between
   elements.  Returns how many were not in it; the hashes of such facets go into p->sum. */
static size_t pbwio__assign_set(pbwio__reader *r, pbwio__inp *p, pbw_index s, int dim, pbw_index *of)
{
    const pbwio__set *set = p->sets.at + s;
    const pbwio__index *n = set->kind == 'n' ? &p->points : &p->elements;
    size_t count = 0, at, entry, k;
    pbw_index i;
    if ((set->kind == 'n') != (dim == 0)) {
        return 0;
    }
    for (i = set->first; i != PBW_NONE; i = p->members.at[i].next) {
        const pbwio__member *m = p->members.at + i;
        for (at = pbwio__from_number(n, m->first); at < n->list.count && n->list.at[at].number <= m->last; at++) {
            const pbwio__numbered *e = n->list.at + at;
            const int side = dim == 0 ? 4 : pbwio__side_of(e, m->side);
            if (++p->steps > 16.0 * (double)(r->end - r->begin) + 65536) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "sets have elements again and again, too often for their text");
                return 0;
            }
            if ((e->number - m->first) % (long long)m->step != 0
                || (dim < 4 ? side != 4 || (dim > 0 && e->dim != dim) : side < 0 || side > 3 || e->dim != 7 - dim)) {
                continue;
            }
            entry = dim < 4 ? e->first : 4 * at + (size_t)side;
            for (k = 0; k < (dim < 4 ? (size_t)e->count : 1); k++) {
                p->sum ^= dim >= 4 && of[entry + k] != s ? pbwio__facet_hash(r->cloud, e, side) : 0;
                count += of[entry + k] != s;
                of[entry + k] = s;
            }
        }
    }
    return count;
}

/* Whether a set is no group of that dimension: a program's own; all points; all elements or the boundary, where this
   header calls it so or other sets have some of them. */
static int pbwio__is_no_group(const pbwio__set *set, int dim, size_t others)
{
    const char *own = dim == 0 ? "NALL" : dim >= 4 ? "BOUNDARY" : "DOMAIN";
    return set->internal || (set->whole && (dim == 0 || others > 0 || pbwio__is(set->name, own)));
}

/* Lists sets that lost members to others; kept: how many each set still has. */
static void pbwio__report_lost(pbwio__reader *r, pbwio__inp *p, int dim, const size_t *kept)
{
    const char *own = dim == 0 ? "NALL" : dim >= 4 ? "BOUNDARY" : "DOMAIN";
    size_t i, used = strlen(p->lost);
    for (i = 0; i < p->sets.count && strstr(p->lost, "...") == NULL; i++) {
        const pbwio__set *set = p->sets.at + i;
        if (kept[i] < set->size && !set->internal && !(set->whole && pbwio__is(set->name, own))) {
            used += (size_t)snprintf(p->lost + used, sizeof p->lost - used, "%s%s", used == 0 ? "" : ", ",
                                     used < sizeof p->lost - 40 ? pbwio__show(r, set->name) : "...");
        }
    }
}

/* Finds out which of the sets are groups of points, elements or facets (dim, as above), makes groups of them, in the
   order of the sets, and puts the numbers of sets into `of`, which has `total` entries; PBW_NONE: in none. */
static void pbwio__assign_sets(pbwio__reader *r, pbwio__inp *p, int dim, pbw_index *of, size_t total)
{
    const uint64_t boundary = p->sum;
    size_t *kept = (size_t *)pbwio__resize(r, NULL, 0, p->sets.count + 1, sizeof *kept), i, others = 0;
    int level;
    if (kept == NULL) {
        return;
    }
    memset(of, 0xff, total * sizeof *of);
    memset(kept, 0, (p->sets.count + 1) * sizeof *kept);
    for (i = 0; i < p->sets.count && r->status == PBWIO_OK; i++) {
        pbwio__set *set = p->sets.at + i;
        p->sum = 0;
        set->size = set->kind == 'n' && pbwio__find_set(r, p, 's', set->name, 0) != PBW_NONE ? 0
                  : pbwio__assign_set(r, p, (pbw_index)i, dim, of);    /* nodes of a surface say no more than that */
        set->whole = set->size > 0 && (dim < 4 ? set->size == total : p->sum == boundary);
        others += set->size > 0 && !set->whole && !set->internal && (set->kind != 's' || dim >= 4);
    }
    memset(of, 0xff, total * sizeof *of);
    for (level = 0; level < 4; level++) {
        for (i = 0; i < p->sets.count && r->status == PBWIO_OK; i++) {
            const pbwio__set *set = p->sets.at + i;
            if (set->size > 0 && !pbwio__is_no_group(set, dim, others)
                && level == (set->kind == 's' && dim < 4 ? 0 : set->whole || set->of_surface ? 1
                             : set->section ? 3 : 2)) {
                (void)pbwio__assign_set(r, p, (pbw_index)i, dim, of);
            }
        }
    }
    for (i = 0; i < total; i++) {
        kept[of[i] == PBW_NONE ? p->sets.count : of[i]]++;
    }
    pbwio__report_lost(r, p, dim, kept);
    for (i = 0; i < p->sets.count && r->status == PBWIO_OK; i++) {
        pbwio__set *set = p->sets.at + i;
        set->group = kept[i] == 0 ? PBW_NONE
                   : pbwio__find_group(r, dim < 4 ? dim : 6 - dim, 0, set->name.begin,
                                       (size_t)(set->name.end - set->name.begin));
    }
    pbwio__release(r, kept, p->sets.count + 1, sizeof *kept);
}

/* Groups of points and elements. */
static void pbwio__inp_groups(pbwio__reader *r, pbwio__inp *p, int dim)
{
    pbwio_cloud *cloud = r->cloud;
    pbw_index **of = pbwio__members(cloud, dim);
    const size_t count = dim == 0 ? cloud->count : dim == 1 ? cloud->segment_count : dim == 2 ? cloud->triangle_count
                       : cloud->tetrahedron_count;
    const size_t size = dim == 0 ? (size_t)cloud->dim * sizeof(double) : ((size_t)dim + 1) * sizeof(pbw_index);
    size_t i, found = 0;
    if (count == 0 || p->sets.count == 0
        || !pbwio__group_room(r, dim, 0, cloud->capacity[PBWIO__OF_ELEMENTS + dim] / size)) {
        return;
    }
    pbwio__assign_sets(r, p, dim, *of, count);
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        found += (*of)[i] != PBW_NONE;
        (*of)[i] = (*of)[i] == PBW_NONE ? PBW_NONE : p->sets.at[(*of)[i]].group;
    }
    if (found == 0) {
        pbwio__free_members(r, dim);
    }
}

/* Groups of facets, of triangles (dim 4) or edges (dim 5), which become elements. */
static void pbwio__inp_surfaces(pbwio__reader *r, pbwio__inp *p, int dim)
{
    const size_t total = 4 * p->elements.list.count;
    pbw_index *of, corner[3];
    size_t i;
    int side;
    for (i = 0; i < p->sets.count && p->sets.at[i].kind != 's'; i++) {
    }
    of = i < p->sets.count && total > 0 ? (pbw_index *)pbwio__resize(r, NULL, 0, total, sizeof *of) : NULL;
    if (of == NULL) {
        return;
    }
    for (i = 0, p->sum = 0; i < p->elements.list.count; i++) {            /* what two elements share cancels */
        const pbwio__numbered *e = p->elements.list.at + i;
        for (side = 0; e->corners > 0 && e->dim == 7 - dim && side < e->corners; side++) {
            p->sum ^= pbwio__facet_hash(r->cloud, e, side);
        }
    }
    pbwio__assign_sets(r, p, dim, of, total);
    for (i = 0; i < total && r->status == PBWIO_OK; i++) {
        if (of[i] != PBW_NONE) {
            (void)pbwio__facet_of(r->cloud, p->elements.list.at + i / 4, (int)(i % 4), corner);
            r->group[6 - dim] = p->sets.at[of[i]].group;
            pbwio__add_simplex(r, 6 - dim, corner);
        }
    }
    pbwio__release(r, of, total, sizeof *of);
}

static void pbwio__read_inp(pbwio__reader *r)
{
    const char *begin = r->at;
    pbwio__inp *p = (pbwio__inp *)pbwio__structure(r, sizeof *p);
    int dim;
    if (p == NULL) {
        return;
    }
    r->passes = 4;
    r->separator = ',';
    pbwio__inp_pass(r, p, begin, 0);
    r->at = begin;
    if (p->node_count > 0) {
        pbwio__choose(r, NULL, p->coordinates, p->coordinates);
        pbwio__reserve(r, p->node_count, 2);
    }
    pbwio__inp_pass(r, p, begin, 1);
    pbwio__sort_numbers(r, &p->points, "node");
    pbwio__inp_pass(r, p, begin, 2);
    pbwio__sort_numbers(r, &p->elements, "element");
    pbwio__inp_pass(r, p, begin, 3);
    for (dim = 0; dim < 4; dim++) {
        pbwio__inp_groups(r, p, dim);
    }
    pbwio__inp_surfaces(r, p, 4);
    pbwio__inp_surfaces(r, p, 5);
    if (p->lost[0] != 0) {
        pbwio__report_dropped(r, "members that other sets have, too, of %s", p->lost);
    }
    PBWIO__RELEASE(r, p->points.list);
    PBWIO__RELEASE(r, p->elements.list);
    PBWIO__RELEASE(r, p->members);
    PBWIO__RELEASE(r, p->sets);
    pbwio__release(r, p->table, p->table_size, sizeof *p->table);
    (void)pbw_memory_resize(&r->cloud->memory, p, 1, 0, sizeof *p);
}

/* ------------------------------------------------------------------------------------------------------
   >>su2          Meshes of SU2, .su2: keys with values, then rows; all after % is a comment.
   In: the file, in two passes: the points, then all elements.  Out: elements; markers as groups of facets.
   Holds: each key has the number of rows that it announces.
   ------------------------------------------------------------------------------------------------------ */

/* Steps to the next line that has something; key: what is before =, empty if it is a row. */
static int pbwio__su2_line(pbwio__reader *r, pbwio__field *key)
{
    while (pbwio__line(r)) {
        const char *stop = (const char *)memchr(r->line, '%', (size_t)(r->line_end - r->line)), *equal;
        pbwio__field all;
        r->line_end = stop != NULL ? stop : r->line_end;
        all = pbwio__trim(r, r->line, r->line_end);
        if (all.begin < all.end) {
            equal = (const char *)memchr(all.begin, '=', (size_t)(all.end - all.begin));
            *key = pbwio__trim(r, all.begin, equal != NULL ? equal : all.begin);
            r->cursor = equal != NULL ? equal + 1 : all.begin;
            return 1;
        }
    }
    return 0;
}

typedef struct pbwio__su2 {
    long long dim, points, left, markers, marked;    /* left: rows that are due */
    int rows;                                /* of this key: 'p' points, 'e' elements, 'm' of a marker, 0 others */
    int named;                               /* a marker */
    pbw_index group;                         /* of the marker */
} pbwio__su2;

/* Takes what a key says. */
static void pbwio__su2_start(pbwio__reader *r, pbwio__su2 *p, pbwio__field key, int pass)
{
    const int rows = pbwio__is(key, "NELEM") ? 'e' : pbwio__is(key, "NPOIN") ? 'p'
                   : pbwio__is(key, "MARKER_ELEMS") ? 'm' : 0;
    if (pbwio__is(key, "SEND_RECV")) {                               /* between a marker and its rows */
        return;
    }
    if (p->left > 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the rows end %lld too early", p->left);
    }
    p->rows = rows;
    if (rows != 0) {
        p->left = pbwio__count(r, "number of rows");
    }
    if (pbwio__is(key, "NDIME")) {
        const long long dim = pbwio__count(r, "dimension");
        if (dim < 2 || dim > 3 || (p->dim != 0 && dim != p->dim)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "dimension %lld", dim);
        }
        p->dim = dim;
    } else if (pbwio__is(key, "NZONE") && pbwio__count(r, "number of zones") > 1) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "files of one zone are read, this has several: write one file a zone");
    } else if (pbwio__is(key, "NMARK")) {
        p->markers = pbwio__count(r, "number of markers");
    } else if (pbwio__is(key, "MARKER_TAG")) {
        const pbwio__field name = pbwio__trim(r, r->cursor, r->line_end);
        p->named = 1;
        p->marked += pass;
        p->group = pass == 0 || name.end == name.begin || pbwio__is(name, "ungrouped") ? PBW_NONE
                 : pbwio__find_group(r, (int)p->dim - 1, 0, name.begin, (size_t)(name.end - name.begin));
    } else if (rows == 'm' && !p->named) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "elements of a marker before MARKER_TAG");
    } else if (rows != 0 && p->dim == 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "rows before NDIME");
    } else if (rows == 'p' && pass == 0) {
        if (r->cloud->points != NULL) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "points twice: files of one zone are read");
        }
        pbwio__choose(r, NULL, (int)p->dim, (int)p->dim);
        pbwio__reserve(r, (unsigned long long)p->left, 2 * (size_t)p->dim);
    } else if (rows == 0 && !pbwio__lists("NZONE IZONE", key)) {
        pbwio__report_once(r, "keys other than of points, elements and markers");
    }
}

/* An element: its type as VTK has it, its points; a number may follow. */
static void pbwio__su2_element(pbwio__reader *r, pbwio__su2 *p)
{
    static const unsigned char nodes[25] = { 0, 1, 0, 2, 0, 3, 0, 0, 0, 4, 4, 0, 8, 6, 5, 0, 0, 0, 0, 0, 0, 3, 6, 8,
                                             10 };
    const long long type = pbwio__count(r, "type of elements");
    long long id[10] = { 0 };
    int k, corners, dim;
    if (type > 24 || nodes[type] == 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "there are no elements of type %lld", type);
        return;
    }
    for (k = 0; k < nodes[type]; k++) {
        id[k] = pbwio__count(r, "point number");
    }
    dim = pbwio__vtk_shape((int)type, &corners);
    if (dim < 0) {
        pbwio__report_once(r, PBWIO__OTHER_SOLIDS);
    } else if (dim == 0) {
        pbwio__report_once(r, "elements of one point");
    } else if (r->status == PBWIO_OK) {
        r->group[dim] = p->rows == 'm' && dim < p->dim ? p->group : PBW_NONE;
        pbwio__add_element(r, dim, corners, nodes[type], id);
    }
}

static void pbwio__read_su2(pbwio__reader *r)
{
    const char *begin = r->at;
    pbwio__su2 p;
    pbwio__field key;
    int pass;
    memset(&p, 0, sizeof p);
    r->passes = 2;
    for (pass = 0; pass < 2; pass++) {
        r->at = r->report_at = begin;
        r->pass = pass;
        r->line_number = 0;
        p.left = p.rows = p.named = 0;
        while (pbwio__su2_line(r, &key)) {
            if (key.begin < key.end) {
                pbwio__su2_start(r, &p, key, pass);
            } else if (p.rows != 0 && p.left-- <= 0) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "more rows than announced");
            } else if (p.rows == 'p' && pass == 0) {
                pbwio__point(r);
            } else if ((p.rows == 'e' || p.rows == 'm') && pass == 1) {
                pbwio__su2_element(r, &p);
            }
        }
        if (p.left > 0) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends %lld rows too early", p.left);
        }
    }
    if (p.marked != p.markers) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "markers: %lld, announced: %lld", p.marked, p.markers);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>json         JSON and GeoJSON.
   In: the file, in two passes: the first counts, the second fills.  Out: points.
   Holds: brackets are at most 64 deep; nothing recurses.

   1. A point is an array of two numbers or more, or an object with the members x and y, or those that the options
      name.
   2. Where there are "coordinates", as in GeoJSON, only arrays within them are points.  The last position of a ring
      is not read twice.
   3. Else the points are the list that the options name, or that is named points, vertices, positions or nodes, or
      the only one.  Lists of edges, faces and the like are none.
   ------------------------------------------------------------------------------------------------------ */
#define PBWIO__DEEPEST 64
#define PBWIO__NUMBERS 16                    /* an array of more numbers is a list, not a point */

#define PBWIO__LISTS 24                      /* lists of other names than the first ones share the last entry */

typedef struct pbwio__list {                 /* points under one name */
    pbwio__field name;
    size_t arrays, objects;                  /* points of each kind */
    int columns, longest;                    /* columns: of the first point; longest: the most numbers of an array */
} pbwio__list;

typedef struct pbwio__json {
    int depth, inside;                       /* of brackets; the depth where "coordinates" start, 0 = not in them */
    char kind[PBWIO__DEEPEST + 1];           /* '[' or '{' at each depth */
    int found[PBWIO__DEEPEST + 1];           /* of objects: bit k is set if member k was there */
    double member[PBWIO__DEEPEST + 1][4];
    pbwio__field key, wanted[4];             /* the last key; the members x y z weight */
    double row[PBWIO__NUMBERS];              /* of the innermost array: its numbers, how many; pure: nothing else */
    int numbers, pure;
    pbwio__field name[PBWIO__DEEPEST + 1];   /* the key of what is at each depth; in arrays that of the array */
    size_t first_point[PBWIO__DEEPEST + 1];  /* the number of points when it started */
    int is_ring[PBWIO__DEEPEST + 1];         /* whether it is a list of positions */
    pbwio__list list[PBWIO__LISTS], coordinates;
    int list_count;
    int source;                              /* 0: counts; else fills with 'c', 'a' or 'o' */
    int all;                                 /* of every list */
    pbwio__field chosen;                     /* the list to fill with */
} pbwio__json;

/* What "a,b,c" names, or x y z. */
static void pbwio__json_names(pbwio__reader *r, pbwio__json *j)
{
    const char *s = r->options->columns != NULL ? r->options->columns : "x,y,z";
    int k;
    memset(j->wanted, 0, sizeof j->wanted);
    for (k = 0; k < 3; k++) {
        j->wanted[k].begin = s;
        s += strcspn(s, ",");
        j->wanted[k].end = s;
        s += *s == ',';
    }
    j->wanted[3].begin = r->options->weight != NULL ? r->options->weight : "";
    j->wanted[3].end = j->wanted[3].begin + strlen(j->wanted[3].begin);
}

static const char pbwio__point_names[] = "points vertices positions nodes";
static const char pbwio__other_names[] = "edges links lines segments faces facets triangles quads polygons cells "
    "elements tetrahedra simplices indices connectivity neighbors bbox";

static int pbwio__same_field(pbwio__field a, pbwio__field b)
{
    return pbwio__same(a.begin, (size_t)(a.end - a.begin), b.begin, (size_t)(b.end - b.begin));
}

/* The list that a point at this depth is of; NULL: it is none of points. */
static pbwio__list *pbwio__json_list(pbwio__json *j)
{
    pbwio__field name = j->name[j->depth];
    int k, known = 0;
    for (k = j->depth; k > 0; k--) {
        if (!known && pbwio__lists(pbwio__other_names, j->name[k])) {
            return NULL;
        }
        if (!known && pbwio__lists(pbwio__point_names, j->name[k])) {
            known = 1;
            name = j->name[k];
        }
    }
    for (k = 0; k < j->list_count && k < PBWIO__LISTS - 1 && !pbwio__same_field(j->list[k].name, name); k++) {
    }
    if (k == j->list_count) {
        j->list[k].name = name;
        j->list_count++;
    }
    return j->list + k;
}

static void pbwio__json_array(pbwio__reader *r, pbwio__json *j)
{
    const int inside = j->inside != 0 && j->depth >= j->inside;
    pbwio__list *list;
    double value[4];
    int k;
    if (!j->pure || j->numbers < 2 || (list = inside ? &j->coordinates : pbwio__json_list(j)) == NULL) {
        return;
    }
    list->columns = list->columns == 0 ? j->numbers : list->columns;
    list->longest = j->numbers > list->longest ? j->numbers : list->longest;
    list->arrays++;
    j->is_ring[j->depth - 1] = inside;
    if (inside ? j->source == 'c' : j->source == 'a' && (j->all || pbwio__same_field(list->name, j->chosen))) {
        if (r->cloud->dim == 2 && j->numbers <= r->column[2]) {
            pbwio__no_heights(r);
        }
        if (j->numbers <= r->last_column) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "%d column%s where %d are needed", j->numbers,
                        j->numbers == 1 ? "" : "s", r->last_column + 1);
            return;
        }
        for (k = 0; k < 4; k++) {
            value[k] = r->column[k] >= 0 ? j->row[r->column[k]] : 0;
        }
        pbwio__add_point(r, value);
    }
}

/* The list of positions at this depth ends: the last one of a ring is its first. */
static void pbwio__json_ring(pbwio__reader *r, const pbwio__json *j)
{
    pbwio_cloud *cloud = r->cloud;
    const size_t first = j->first_point[j->depth], dim = (size_t)cloud->dim;
    if (j->source == 'c' && j->is_ring[j->depth] && !(r->options->flags & PBWIO_CLOSED_RINGS)
        && cloud->count >= first + 4
        && memcmp(cloud->points + dim * first, cloud->points + dim * (cloud->count - 1), dim * sizeof(double)) == 0) {
        cloud->count--;
    }
}

static void pbwio__json_object(pbwio__reader *r, pbwio__json *j)
{
    int found = j->found[j->depth], needed = 3, k;
    pbwio__list *list;
    if ((found & 3) != 3 || (list = pbwio__json_list(j)) == NULL) {
        return;
    }
    list->columns = list->objects == 0 ? (found & 4 ? 3 : 2) : list->columns;
    list->objects++;
    if (j->source == 'o' && (j->all || pbwio__same_field(list->name, j->chosen))) {
        for (k = 2; k < 4; k++) {
            needed |= r->column[k] >= 0 && (k == 3 || r->cloud->dim == 3) ? 1 << k : 0;
        }
        if (r->cloud->dim == 2 && !(found & 4)) {
            pbwio__no_heights(r);
        }
        if ((found & needed) != needed) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "a point lacks a coordinate or its weight");
            return;
        }
        pbwio__add_point(r, j->member[j->depth]);
    }
}

static void pbwio__json_number(pbwio__reader *r, pbwio__json *j, pbwio__field field)
{
    double value;
    int k;
    if (!pbwio__number(field.begin, field.end, &value)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a finite number", pbwio__show(r, field));
    } else if (j->kind[j->depth] == '[') {
        if (j->numbers < PBWIO__NUMBERS) {
            j->row[j->numbers] = value;
        }
        j->numbers += j->numbers <= PBWIO__NUMBERS;
    } else {
        for (k = 0; k < 4; k++) {
            size_t length = (size_t)(j->wanted[k].end - j->wanted[k].begin);
            if (length > 0 && pbwio__same(j->key.begin, (size_t)(j->key.end - j->key.begin), j->wanted[k].begin,
                                          length)) {
                j->member[j->depth][k] = value;
                j->found[j->depth] |= 1 << k;
            }
        }
    }
}

/* An opening or closing bracket. */
static void pbwio__json_bracket(pbwio__reader *r, pbwio__json *j, char c)
{
    if (c == '[' || c == '{') {
        if (j->depth == PBWIO__DEEPEST) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "brackets more than %d deep", PBWIO__DEEPEST);
            return;
        }
        if (j->inside == 0 && c == '[' && j->kind[j->depth] == '{' && pbwio__is(j->key, "coordinates")) {
            j->inside = j->depth + 1;
        }
        j->name[j->depth + 1] = j->kind[j->depth] == '{' ? j->key : j->name[j->depth];
        j->kind[++j->depth] = c;
        j->found[j->depth] = j->is_ring[j->depth] = j->numbers = 0;
        j->first_point[j->depth] = r->cloud->count;
        j->pure = c == '[';
        return;
    }
    if (j->depth == 0 || j->kind[j->depth] != (c == ']' ? '[' : '{')) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%c\" closes nothing", c);
        return;
    }
    if (c == ']') {
        pbwio__json_array(r, j);
        pbwio__json_ring(r, j);
    } else {
        pbwio__json_object(r, j);
    }
    j->inside = j->depth == j->inside ? 0 : j->inside;
    j->pure = 0;                                                     /* what it is in has more than numbers */
    j->depth--;
}

/* A string, a number or a word at r->at. */
static void pbwio__json_value(pbwio__reader *r, pbwio__json *j)
{
    pbwio__field field;
    const char *s = r->at;
    if (*s == '"') {
        for (s++; s < r->end && *s != '"'; s++) {
            s += *s == '\\' && s + 1 < r->end;
        }
        field.begin = r->at + 1;
        field.end = s;
        r->at = s < r->end ? s + 1 : s;
        while (s < r->end && ++s < r->end && pbwio__blank(r, *s)) {
        }
        if (j->kind[j->depth] == '{' && s < r->end && *s == ':') {
            j->key = field;
            r->at = s + 1;
        } else {
            j->pure = 0;
        }
        return;
    }
    for (; s < r->end && !pbwio__blank(r, *s) && strchr(",:[]{}\"", *s) == NULL; s++) {
    }
    field.begin = r->at;
    field.end = s;
    if (s == r->at) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%c\" has no place here", *s == 0 ? '?' : *s);
    } else if (pbwio__is(field, "null") || pbwio__is(field, "true") || pbwio__is(field, "false")) {
        j->pure = 0;
    } else {
        pbwio__json_number(r, j, field);
    }
    r->at = s;
}

static void pbwio__json_pass(pbwio__reader *r, pbwio__json *j)
{
    while (r->at < r->end && r->status == PBWIO_OK) {
        char c = *r->at;
        if (r->report_at != NULL && r->at >= r->report_at) {
            pbwio__report(r);
        }
        if (pbwio__blank(r, c) || c == ',') {
            r->at++;
        } else if (c == '[' || c == '{' || c == ']' || c == '}') {
            pbwio__json_bracket(r, j, c);
            r->at++;
        } else {
            pbwio__json_value(r, j);
        }
    }
    if (j->depth != 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends inside brackets");
    }
}

/* Decides which list has the points, into chosen or all, and how: 'c' coordinates, 'o' objects, 'a' arrays. */
static pbwio__list pbwio__json_choose(pbwio__reader *r, pbwio__json *j)
{
    pbwio__list total = j->coordinates, *found = NULL;
    char text[256] = "";
    int k, rank, best = 0, matches = 0, single = 1;
    j->source = 'c';
    for (k = 0; k < j->list_count && total.arrays == 0; k++) {       /* named by options, by habit; objects; arrays */
        pbwio__list *list = j->list + k;
        rank = j->chosen.begin < j->chosen.end && pbwio__same_field(list->name, j->chosen) ? 4
             : pbwio__lists(pbwio__point_names, list->name) ? 3
             : list->objects > 0 ? 2 : list->arrays > 0;
        if (rank > best) {
            best = rank;
            matches = 0;
            single = 1;
            text[0] = 0;
        }
        if (rank == best && rank > 0) {
            const size_t used = strlen(text), count = list->objects > 0 ? list->objects : list->arrays;
            snprintf(text + used, sizeof text - used, "%s%s (%zu)", matches > 0 ? ", " : "",
                     list->name.begin < list->name.end ? pbwio__show(r, list->name) : "without a name", count);
            found = list;
            matches++;
            single &= count == 1;
        }
    }
    if (j->chosen.begin < j->chosen.end && best < 4) {
        pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "no list of points is named so%s%s", best > 0 ? "; there are " : "",
                    text);
    } else if (matches > 1 && !single) {
        pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "several lists may be the points: %s; choose one by columns (--columns "
                    "NAME or NAME:x,y)", text);
    } else if (found != NULL) {
        total = *found;
        j->all = matches > 1;
        for (k = 0; k < j->list_count && j->all; k++) {              /* each point has a name of its own */
            total.objects += j->list + k != found ? j->list[k].objects : 0;
            total.arrays += j->list + k != found ? j->list[k].arrays : 0;
            total.longest = j->list[k].longest > total.longest ? j->list[k].longest : total.longest;
        }
        j->chosen = total.name;
        j->source = total.objects > 0 ? 'o' : 'a';
    }
    return total;
}

/* Reads with the columns of the options, without the name of a list. */
static void pbwio__json_points(pbwio__reader *r, pbwio__field chosen)
{
    const char *begin = r->at;
    pbwio__json j;
    pbwio__list list;
    size_t count;
    int source, all, k;
    memset(&j, 0, sizeof j);
    j.key.begin = j.key.end = j.name[0].begin = j.name[0].end = begin;
    j.chosen = chosen;
    pbwio__json_names(r, &j);
    r->passes = 2;
    pbwio__json_pass(r, &j);
    list = pbwio__json_choose(r, &j);
    source = j.source;
    all = j.all;
    chosen = j.chosen;
    count = source == 'o' ? list.objects : list.arrays;
    if (r->status == PBWIO_OK && (count == 0 || (source != 'o' && list.longest > PBWIO__NUMBERS))) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, count == 0 ? "no points: arrays of numbers, or objects with x and y"
                    : "a list of many numbers: points are arrays of two or three");
    }
    r->at = r->report_at = begin;
    r->pass = 1;
    if (source == 'o') {
        r->cloud->dim = list.columns == 3 && r->options->dim != 2 ? 3 : 2;
        for (k = 0; k < 4; k++) {
            r->column[k] = k < (list.columns == 3 ? 3 : 2) || (k == 3 && r->options->weight != NULL) ? k : -1;
        }
        if (r->options->dim > r->cloud->dim) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "%d coordinates where 3 are needed", list.columns);
        }
    } else {
        pbwio__choose(r, NULL, list.columns < 3 ? list.columns : 3, list.columns);
    }
    pbwio__reserve(r, count, 4);
    memset(&j, 0, sizeof j);
    j.key.begin = j.key.end = j.name[0].begin = j.name[0].end = begin;
    pbwio__json_names(r, &j);
    j.source = source;
    j.all = all;
    j.chosen = chosen;
    pbwio__json_pass(r, &j);
}

static void pbwio__read_json(pbwio__reader *r)
{
    const pbwio_options *given = r->options;
    pbwio_options options = *given;
    pbwio__field chosen = { "", "" };
    const char *s = options.columns, *colon = s != NULL ? strchr(s, ':') : NULL;
    chosen.end = chosen.begin;
    if (colon != NULL || (s != NULL && strchr(s, ',') == NULL)) {
        chosen.begin = s;
        chosen.end = colon != NULL ? colon : s + strlen(s);
        options.columns = colon != NULL && colon[1] != 0 ? colon + 1 : NULL;
    }
    r->options = &options;
    pbwio__json_points(r, chosen);
    r->options = given;
}

/* ------------------------------------------------------------------------------------------------------
   >>writer       Values, rows and forms of files.
   In: a mesh.  Out: a stream.
   Holds: the first failure of the stream stays in it and is found when it is closed.

   A form is the text of a file with these directives in it.
     %n      stands for numbers, n says which (pbwio__numbers); in text they are set apart by one character
     #1 &1   the number 1 in 4 or 8 bytes, of one digit
     @p      starts a row, a line that is written for each point; @b those of the boundary, @n those with normals;
             @c each simplex, @f each facet, @h those of the hull, @e each edge; @s each triangle of a surface, in 3D
             the facets, else the simplices; @1 once.  In binary files rows are binary and have no ends, other lines
             are text.
     |       ends a line within a row
     [c ..]  is there if the condition c holds (pbwio__condition)
   ------------------------------------------------------------------------------------------------------ */
enum { PBWIO__FACETS, PBWIO__CELLS, PBWIO__EDGES, PBWIO__MARKED, PBWIO__PARTS };     /* marked: points in groups */

typedef struct pbwio__item {                 /* a facet, a simplex, an edge or a point of a group */
    pbw_index group;                         /* as the caller has it */
    pbw_index inside, outside;               /* of a facet: regions on both sides, PBW_NONE outside */
    size_t simplex, k, cell, end;            /* as in the writer; of the first of a run: where that ends */
} pbwio__item;

typedef struct pbwio__writer {
    const pbw_mesh *mesh;
    const double *normals;                   /* 3 a point, or NULL */
    const pbwio_output *output;
    pbw_memory memory;
    FILE *file;
    size_t rows, all_rows;                   /* written; an estimate of all */
    int cancelled;                           /* nothing more is written */
    int binary, text;                        /* binary: what the format is; text: how values are written just now */
    int separator, pending;                  /* text: what is between values; whether it is due before the next one */
    int longest;                             /* text: the most characters that a number may have */
    size_t id_size, real_size;               /* bytes of a point id and of a coordinate in binary */
    unsigned base;                           /* the first number of points and elements */
    size_t dim, corners;                     /* coordinates; corners of a simplex: dim+1, or 3 in a model */
    pbw_index *number;                       /* of a point or simplex in the file; PBW_NONE: left out; NULL: itself */
    unsigned char *boundary;                 /* 1 for the points on facets; NULL: nobody asks */
    size_t point_count, cell_count, facet_count;     /* what the file holds */
    size_t point, simplex, k;                /* the row at hand: its point, or its simplex and which facet of that;
                                                k = corners: the simplex itself; corners + 1, corners + 2: edge or
                                                point `simplex` */
    size_t cell, element, node;              /* simplices, elements, and nodes of elements that came before it */
    size_t column;                           /* the column at hand */
    pbwio__item *items;                      /* by parts, in each of them in runs of one group; NULL: none */
    size_t first[PBWIO__PARTS + 1];          /* where each part starts */
    long long largest;                       /* of the caller's tags that a file can have */
    pbw_index builtin[2];                    /* of .inp: the patch and the region that BOUNDARY and DOMAIN are, by
                                                parts; PBW_NONE: none */
    char **words;                            /* of .inp and .su2: names of the caller's groups; NULL: as they are */
    size_t words_size, number_size, item_capacity;       /* bytes, bytes, items */
    char name[32];                           /* of a group that the caller does not name */
    size_t used;
    char buffer[16384];
} pbwio__writer;

/* Edge k of a triangle is across from corner k and turns counter-clockwise. */
static const unsigned char pbwio__facet2[3][2] = { { 1, 2 }, { 2, 0 }, { 0, 1 } };

#define PBWIO__MOST_TAG 1000000000         /* where tags are numbers of groups by name; larger ones are replaced */

static void pbwio__flush(pbwio__writer *w)
{
    fwrite(w->buffer, 1, w->used, w->file);
    w->used = 0;
}

static void pbwio__put(pbwio__writer *w, const void *data, size_t size)      /* size <= 4096 */
{
    if (w->used + size > sizeof w->buffer) {
        pbwio__flush(w);
    }
    memcpy(w->buffer + w->used, data, size);
    w->used += size;
}

PBWIO__PRINTF(2, 3)
static void pbwio__print(pbwio__writer *w, const char *format, ...)
{
    char text[1024];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    pbwio__put(w, text, strlen(text));
}

/* The separator that is due before the next value. */
static void pbwio__put_separator(pbwio__writer *w)
{
    char between = (char)w->separator;
    pbwio__put(w, &between, (size_t)w->pending);
    w->pending = 0;
}

static void pbwio__int(pbwio__writer *w, long long value, size_t size)
{
    unsigned long long rest = value < 0 ? 0 - (unsigned long long)value : (unsigned long long)value;
    char digits[24];
    size_t at = sizeof digits;
    uint64_t wide = (uint64_t)value;
    uint32_t narrow = (uint32_t)wide;
    unsigned char byte = (unsigned char)wide;
    if (!w->text) {
        pbwio__put(w, size == 8 ? (void *)&wide : size == 4 ? (void *)&narrow : (void *)&byte, size);
        return;
    }
    do {
        digits[--at] = (char)('0' + rest % 10);
        rest /= 10;
    } while (rest != 0);
    if (value < 0) {
        digits[--at] = '-';
    }
    pbwio__put_separator(w);
    pbwio__put(w, digits + at, sizeof digits - at);
    w->pending = 1;
}

static void pbwio__real(pbwio__writer *w, double x)
{
    char text[40];
    float single = (float)x;
    if (!w->text) {
        pbwio__put(w, w->real_size == 4 ? (void *)&single : (void *)&x, w->real_size);
        return;
    }
    pbwio__put_separator(w);
    pbwio__put(w, text, (size_t)pbwio__print_number(text, x, w->longest));
    w->pending = 1;
}

static void pbwio__end_line(pbwio__writer *w)
{
    if (w->text) {
        pbwio__put(w, "\n", 1);
    }
    w->pending = 0;
}

static int pbwio__kept(const pbwio__writer *w, size_t simplex)
{
    return w->output->keep == NULL || w->output->keep[simplex] != 0;
}

/* Whether a facet is on the hull; 0 for all if the mesh has no neighbours. */
static int pbwio__on_hull(const pbwio__writer *w, size_t simplex, size_t k)
{
    pbw_index other = w->mesh->neighbors == NULL ? 0 : w->mesh->neighbors[w->corners * simplex + k];
    return w->mesh->neighbors != NULL && (other == PBW_NONE || !pbwio__kept(w, other));
}

/* The corners of the element at hand.  Returns how many. */
static size_t pbwio__corners(const pbwio__writer *w, pbw_index corner[4])
{
    const pbw_index *all = w->mesh->simplices + w->corners * w->simplex;
    size_t i, k = w->k, count = w->corners - (k < w->corners);
    if (k > w->corners) {
        count = w->corners + 3 - k;
        corner[0] = count == 1 ? (pbw_index)w->simplex : w->output->edges[2 * w->simplex];
        corner[1] = count == 1 ? PBW_NONE : w->output->edges[2 * w->simplex + 1];
        return count;
    }
    for (i = 0; i < count; i++) {
        corner[i] = all[k == w->corners ? i : w->corners == 4 ? PBW_FACET_CORNER(k, i) : pbwio__facet2[k][i]];
    }
    return count;
}

static void pbwio__rewind(pbwio__writer *w)
{
    w->simplex = w->cell = 0;
    w->k = (size_t)-1;
}

/* Steps to the next simplex that is kept, or to the next facet of their hull.  Returns 0 if there is none. */
static int pbwio__step(pbwio__writer *w, int facets)
{
    for (w->k++; w->simplex < w->mesh->simplex_count; w->simplex++, w->k = 0) {
        if (pbwio__kept(w, w->simplex)) {
            w->k = !facets && w->k == 0 ? w->corners : w->k;
            while (w->k < w->corners && !pbwio__on_hull(w, w->simplex, w->k)) {
                w->k++;
            }
            if (w->k < w->corners + !facets) {
                return 1;
            }
            w->cell++;
        }
    }
    return 0;
}

/* 1 for each point that is a corner of a simplex or a facet; NULL: out of memory. */
static unsigned char *pbwio__used_points(pbwio__writer *w, int facets)
{
    unsigned char *used = (unsigned char *)pbw_memory_resize(&w->memory, NULL, 0, w->mesh->point_count + 1, 1);
    pbw_index corner[4];
    size_t i, n;
    if (used != NULL) {
        memset(used, 0, w->mesh->point_count + 1);
        pbwio__rewind(w);
        while (pbwio__step(w, facets)) {
            for (i = 0, n = pbwio__corners(w, corner); i < n; i++) {
                used[corner[i]] = 1;
            }
        }
    }
    return used;
}

/* Numbers the points that the file will hold, the corners of what is written.  Returns whether there is memory. */
static int pbwio__number_points(pbwio__writer *w, int facets)
{
    const size_t size = (w->mesh->point_count + 1) * sizeof *w->number * (w->output->format == PBWIO_INP ? 2 : 1);
    size_t i;
    unsigned char *used = pbwio__used_points(w, facets);
    if (used == NULL || !pbw_memory_fit(&w->memory, &w->number, &w->number_size, size, 1)) {
        (void)pbw_memory_resize(&w->memory, used, w->mesh->point_count + 1, 0, 1);
        return 0;
    }
    w->point_count = 0;
    for (i = 0; i < w->mesh->point_count; i++) {
        w->number[i] = used[i] ? (pbw_index)w->point_count++ : PBW_NONE;
    }
    (void)pbw_memory_resize(&w->memory, used, w->mesh->point_count + 1, 0, 1);
    return 1;
}

/* Mean ratio: 12 (3 volume)^(2/3) or 4 sqrt(3) area, over the sum of the squared edge lengths; n corners. */
static double pbwio__quality(const pbw_mesh *mesh, size_t n, size_t simplex)
{
    const size_t dim = (size_t)mesh->dim;
    const pbw_index *corner = mesh->simplices + n * simplex;
    double edge[3][3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 1 } }, across[3], sum = 0, d, size;
    size_t i, j, k;
    for (i = 0; i < n; i++) {
        for (j = i + 1; j < n; j++) {
            for (k = 0; k < dim; k++) {
                d = mesh->points[dim * corner[j] + k] - mesh->points[dim * corner[i] + k];
                edge[j - 1][k] = i == 0 ? d : edge[j - 1][k];
                sum += d * d;
            }
        }
    }
    for (k = 0; k < 3; k++) {
        across[k] = edge[0][(k + 1) % 3] * edge[1][(k + 2) % 3] - edge[0][(k + 2) % 3] * edge[1][(k + 1) % 3];
    }
    size = n < dim + 1 ? sqrt(across[0] * across[0] + across[1] * across[1] + across[2] * across[2])
         : across[0] * edge[2][0] + across[1] * edge[2][1] + across[2] * edge[2][2];
    size = size > 0 ? size : 0;                                      /* 6 volumes or 2 areas; may round below 0 */
    d = n == 4 ? 12 * pow(size / 2, 2.0 / 3.0) / sum : 2 * sqrt(3.0) * size / sum;
    return d >= 0 && d <= 1 ? d : d > 1 ? 1 : 0;
}

/* Coordinate k of a point, 0 to 2; in the plane the third is its height, else 0. */
static double pbwio__coordinate(const pbwio__writer *w, size_t point, size_t k)
{
    return k < w->dim ? w->mesh->points[w->dim * point + k] : w->output->heights != NULL ? w->output->heights[point]
         : 0;
}

/* The least (sign 1) or the greatest (-1) coordinate k of all points, 0 if there are none. */
static double pbwio__extreme(const pbwio__writer *w, size_t k, double sign)
{
    double extreme = 0, x;
    size_t i;
    for (i = 0; i < w->mesh->point_count; i++) {
        x = pbwio__coordinate(w, i, k);
        extreme = i == 0 || sign * x < sign * extreme ? x : extreme;
    }
    return extreme;
}

/* The normal of a triangle, of length 1 or 0, and its corners, as .stl has them. */
static void pbwio__triangle(const pbwio__writer *w, double row[4][3])
{
    double a[3], b[3], size = 0;
    pbw_index corner[4];
    size_t i, k;
    pbwio__corners(w, corner);
    for (i = 0; i < 9; i++) {
        row[1 + i / 3][i % 3] = pbwio__coordinate(w, corner[i / 3], i % 3);
    }
    for (k = 0; k < 3; k++) {
        a[k] = row[2][k] - row[1][k];
        b[k] = row[3][k] - row[1][k];
    }
    for (k = 0; k < 3; k++) {
        row[0][k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        size += row[0][k] * row[0][k];
    }
    for (k = 0; k < 3; k++) {
        row[0][k] = size > 0 ? (double)(float)(row[0][k] / sqrt(size)) : 0;
    }
}

/* The number in the file of a point, or of a simplex in a format of simplices alone. */
static long long pbwio__number_of(const pbwio__writer *w, size_t i)
{
    return (long long)(w->number == NULL ? i : w->number[i]) + w->base;
}

/* Whether the format counts its groups, from 1 on, and so may have none of tag 0. */
static int pbwio__has_numbers(const pbwio__writer *w)
{
    const pbwio_format format = w->output->format;
    return format == PBWIO_MSH || format == PBWIO_MSH2 || format == PBWIO_INP || format == PBWIO_SU2;
}

/* A group of the caller's, with a new tag after the largest where the format cannot have its own. */
static pbwio_group pbwio__caller_group(const pbwio__writer *w, pbw_index number)
{
    pbwio_group group = w->output->groups[number];
    if (pbwio__has_numbers(w) && (group.tag < 1 || group.tag > PBWIO__MOST_TAG)) {
        group.tag = w->largest + 3 + (long long)number;
    }
    group.name = w->words != NULL ? w->words[number] : group.name;
    return group;
}

/* The group of the element at hand; none: tag 0. */
static pbwio_group pbwio__group(pbwio__writer *w)
{
    static const char *const names[] = { "boundary", "domain", "edges", "points", "interface" };
    const pbwio_output *o = w->output;
    const pbw_index *const groups[] = { o->patches, o->regions, o->edge_groups, o->point_groups };
    const size_t part = w->k < w->corners ? (size_t)PBWIO__FACETS : w->k - w->corners + PBWIO__CELLS;
    size_t what = part;
    pbw_index number;
    pbwio_group group;
    group.dim = part >= PBWIO__EDGES ? (int)(PBWIO__MARKED - part)
              : (int)(w->corners - 1 - (part == PBWIO__FACETS));
    group.tag = 0;
    group.name = NULL;
    if (groups[part] == NULL && o->groups != NULL && o->group_count == 0) {
        return group;
    }
    if (groups[part] == NULL) {                      /* the default groups */
        what = part == PBWIO__FACETS && !pbwio__on_hull(w, w->simplex, w->k) ? (size_t)PBWIO__PARTS : part;
        group.tag = (what == PBWIO__CELLS || what == PBWIO__PARTS) + 1;
        group.tag += o->groups != NULL && w->largest > 0 ? w->largest : 0;
        group.name = (char *)(uintptr_t)names[what];
        return group;
    }
    number = groups[part][part == PBWIO__FACETS ? w->corners * w->simplex + w->k : w->simplex];
    if (o->groups != NULL && number < o->group_count) {
        return pbwio__caller_group(w, number);
    }
    if (o->groups == NULL && number < 0x7ffffffe) {
        group.tag = (long long)number + 1 + (o->format == PBWIO_MESH && part == PBWIO__CELLS);
        sprintf(w->name, part == PBWIO__FACETS ? "patch_%lu" : "region_%lu", (unsigned long)number);
    } else if (o->groups == NULL) {
        group.tag = pbwio__has_numbers(w) ? 0x7fffffff : 0;
        strcpy(w->name, part == PBWIO__FACETS ? "hole" : "none");
    }
    group.name = o->groups == NULL ? w->name : NULL;
    return group;
}

/* Of an element. */
static void pbwio__element_numbers(pbwio__writer *w, char which)
{
    static const unsigned char side2[3] = { 2, 3, 1 }, side3[4] = { 3, 4, 2, 1 };    /* as Abaqus counts facets */
    static const unsigned char gmsh[5] = { 0, 15, 1, 2, 4 }, vtk[5] = { 0, 1, 3, 5, 10 };     /* by corners */
    const pbw_mesh *mesh = w->mesh;
    size_t i, n;
    double row[4][3];
    pbw_index corner[4];
    switch (which) {
        /* its number among both, its points, the same with their normals */
        case 'j': pbwio__int(w, (long long)(w->element + w->base), 8); break;
        case 'v':
        case 'V':
            for (i = 0, n = pbwio__corners(w, corner); i < n; i++) {
                pbwio__int(w, pbwio__number_of(w, corner[i]), w->id_size);
                if (which == 'V' && w->normals != NULL) {
                    pbwio__put(w, "//", 2);
                    w->pending = 0;
                    pbwio__int(w, pbwio__number_of(w, corner[i]), 4);
                }
            }
            break;
        /* of a triangle: its normal, its corners, two bytes that nobody uses */
        case 'N': case '0': case '1': case '2':
            pbwio__triangle(w, row);
            for (i = 0; i < 3; i++) {
                pbwio__real(w, row[which == 'N' ? 0 : which - '0' + 1][i]);
            }
            break;
        case 'z': pbwio__put(w, "\0", 2); break;
        /* the tag of its group; its entity in Gmsh; its type in Gmsh */
        case 'P': pbwio__int(w, pbwio__group(w).tag, 4); break;
        case 'E': pbwio__int(w, pbwio__group(w).tag > 0 ? pbwio__group(w).tag : w->largest + 1, 4); break;
        case 'T': pbwio__int(w, gmsh[pbwio__corners(w, corner)], 4); break;
        /* of a facet: the number of its simplex, which facet of that it is */
        case 'p': pbwio__int(w, (long long)(w->cell + w->base), 8); break;
        case 'k': pbwio__int(w, w->corners == 4 ? side3[w->k] : side2[w->k], 4); break;
        /* of a simplex: neighbours, across from the corners, -1 = the hull; quality; the caller's value.  Where its
           corners end in a list of all; its type in VTK */
        case 'g':
            for (i = 0; i < w->corners; i++) {
                pbw_index other = mesh->neighbors[w->corners * w->simplex + i];
                pbwio__int(w, pbwio__on_hull(w, w->simplex, i) ? -1 : pbwio__number_of(w, other), 4);
            }
            break;
        case 'q': pbwio__real(w, w->k > w->corners ? 0 : pbwio__quality(mesh, w->corners, w->simplex)); break;
        case 'u': pbwio__real(w, w->k > w->corners ? 0 : w->output->values[w->simplex]); break;
        case 'a': pbwio__int(w, (long long)(w->node += pbwio__corners(w, corner)), 8); break;
        case 't': pbwio__int(w, vtk[pbwio__corners(w, corner)], 1); break;
        /* of a simplex, a facet, an edge: the tag of its group, else 0 */
        case 'G': pbwio__int(w, w->k == w->corners ? pbwio__group(w).tag : 0, 8); break;
        case 'S': pbwio__int(w, w->k < w->corners ? pbwio__group(w).tag : 0, 8); break;
        case 'L': pbwio__int(w, w->k == w->corners + 1 ? pbwio__group(w).tag : 0, 8); break;
    }
}

/* How many coordinates a point has: in the plane 3 where there are heights. */
static size_t pbwio__width(const pbwio__writer *w)
{
    return w->output->heights != NULL ? 3 : w->dim;
}

/* The tag of the group that the point at hand is in, 0 if it is in none. */
static long long pbwio__marker(const pbwio__writer *w)
{
    const pbw_index group = w->output->point_groups == NULL || w->output->groups == NULL ? PBW_NONE
                          : w->output->point_groups[w->point];
    return group == PBW_NONE ? 0 : w->output->groups[group].tag;
}

/* Writes a name as XML has it. */
static void pbwio__put_escaped(pbwio__writer *w, const char *s)
{
    for (; *s != 0; s++) {
        if (strchr("&<>\"", *s) != NULL || (unsigned char)*s < ' ') {
            pbwio__print(w, "&#%d;", *s);
        } else {
            pbwio__put(w, s, 1);
        }
    }
}

/* The name of a column, or attribute_1 and so on: in .vtu as XML has it, in .csv in quotes if it must be, in .ply
   without what its reader takes for the end of a name. */
static void pbwio__column_name(pbwio__writer *w, size_t column)
{
    const char *s = w->output->columns[column].name;
    const pbwio_format format = w->output->format;
    const int quoted = format == PBWIO_CSV && s != NULL && strpbrk(s, ",\"\r\n") != NULL;
    if (s == NULL || *s == 0) {
        pbwio__print(w, "attribute_%zu", column + 1);
        return;
    }
    pbwio__put(w, "\"", (size_t)quoted);
    for (; *s != 0; s++) {
        if (format == PBWIO_VTU && strchr("&<\"", *s) != NULL) {
            pbwio__print(w, "&#%d;", *s);
        } else {
            const char c = format == PBWIO_PLY && (unsigned char)*s <= ' ' ? '_' : *s;
            pbwio__put(w, "\"", quoted && c == '"');
            pbwio__put(w, &c, 1);
        }
    }
    pbwio__put(w, "\"", (size_t)quoted);
}

/* Of a point, behind its coordinates in the plane or in space: columns, a height, a weight. */
static size_t pbwio__attribute_count(const pbwio__writer *w)
{
    return w->output->column_count + pbwio__width(w) - w->dim + (w->mesh->weights != NULL);
}

static void pbwio__numbers(pbwio__writer *w, char which)
{
    const pbw_mesh *mesh = w->mesh;
    size_t i, width = 3, surface = w->corners == 4 ? w->facet_count : w->cell_count;
    switch (which) {
        /* of the mesh */
        case 'd': pbwio__int(w, mesh->dim, 4); break;
        case 'D': pbwio__int(w, (long long)pbwio__width(w), 4); break;
        case 'A': pbwio__int(w, (long long)pbwio__attribute_count(w), 4); break;
        case 'H':                                                    /* the names of columns */
            for (i = 0; i < w->output->column_count; i++) {
                pbwio__print(w, w->output->format == PBWIO_PLY ? "property double " : ",");
                pbwio__column_name(w, i);
                pbwio__print(w, w->output->format == PBWIO_PLY ? "\n" : "");
            }
            break;
        case 'n': pbwio__int(w, (long long)w->point_count, 8); break;
        case 'c': pbwio__int(w, (long long)w->cell_count, 8); break;
        case 'f': pbwio__int(w, (long long)w->facet_count, 8); break;
        case 's': pbwio__int(w, (long long)surface, 4); break;
        case 'l': pbwio__int(w, (long long)(w->first[PBWIO__MARKED] - w->first[PBWIO__EDGES]), 8); break;
        case 'e': pbwio__int(w, (long long)(w->items != NULL ? w->first[PBWIO__PARTS]
                                            : w->cell_count + w->facet_count), 8); break;
        case 'B':                                                    /* the box around all points */
            for (i = 0; i < 6; i++) {
                pbwio__real(w, pbwio__extreme(w, i % 3, i < 3 ? 1 : -1));
            }
            break;
        /* of a point: its number and id, coordinates (those of the plane, with a height, 3 of them), weight, normal,
           columns, the column at hand, height, marker */
        case 'i': pbwio__int(w, pbwio__number_of(w, w->point), 8); break;
        case 'o': pbwio__int(w, (long long)w->point, 4); break;
        case 'y':
        case 'x': width = which == 'y' ? w->dim : pbwio__width(w);   /* fall through */
        case 'X':
            for (i = 0; i < width; i++) {
                pbwio__real(w, pbwio__coordinate(w, w->point, i));
            }
            break;
        case 'C':
            for (i = 0; i < w->output->column_count; i++) {
                pbwio__real(w, w->output->columns[i].values[w->point]);
            }
            break;
        case 'K': pbwio__real(w, w->output->columns[w->column].values[w->point]); break;
        case 'h':
            if (pbwio__width(w) > w->dim) {
                pbwio__real(w, w->output->heights[w->point]);
            }
            break;
        case 'M': pbwio__int(w, pbwio__marker(w), 8); break;
        case 'w':
            if (mesh->weights != NULL) {
                pbwio__real(w, mesh->weights[w->point]);
            }
            break;
        case 'm':
            for (i = 0; i < 3 && w->normals != NULL; i++) {
                pbwio__real(w, w->normals[3 * w->point + i]);
            }
            break;
        case 'b':
            pbwio__int(w, w->output->point_groups != NULL ? pbwio__marker(w)
                       : w->boundary != NULL && w->boundary[w->point], 4);
            break;
        default: pbwio__element_numbers(w, which);
    }
}

static int pbwio__little_endian(void)
{
    const uint32_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 1;
}

static int pbwio__condition(const pbwio__writer *w, char condition)
{
    switch (condition) {
        case '2': return w->corners == 3;
        case '3': return w->corners == 4;
        case 'w': return w->mesh->weights != NULL;
        case 'z': return pbwio__width(w) == 3;
        case 'Z': return pbwio__width(w) == 2;
        case 'M': return w->output->point_groups != NULL;
        case 'W': return w->mesh->weights == NULL;
        case 'm': return w->normals != NULL;
        case 'a': return w->output->regions != NULL;
        case 'A': return w->output->regions == NULL;
        case 'e': return w->first[PBWIO__MARKED] > w->first[PBWIO__EDGES];
        case 'f': return w->facet_count != 0;
        case 'F': return w->facet_count == 0;
        case 's': return w->corners == 4 ? w->facet_count != 0 : w->cell_count != 0;
        case 't': return !w->binary;
        case 'b': return w->binary;
        default: return w->binary && pbwio__little_endian() == (condition == 'l');    /* l, g: byte order */
    }
}

/* Writes the directive or the character at s.  Returns where the next one is. */
static const char *pbwio__directive(pbwio__writer *w, const char *s)
{
    int depth = 1;
    if (*s == '%') {
        pbwio__numbers(w, s[1]);
        return s + 2;
    }
    if (*s == '#' || *s == '&') {
        pbwio__int(w, s[1] - '0', *s == '#' ? 4 : 8);
        return s + 2;
    }
    if (*s == '[') {
        if (!pbwio__condition(w, s[1])) {
            for (s += 2; depth > 0; s++) {
                depth += (*s == '[') - (*s == ']');
            }
            return s;
        }
        return s + 2;
    }
    if (*s == '\n' || *s == '|') {
        pbwio__end_line(w);
    } else if (*s != ']') {
        pbwio__put_separator(w);
        pbwio__put(w, s, 1);
    }
    return s + 1;
}

/* Makes item i the current one. */
static void pbwio__seek(pbwio__writer *w, size_t i)
{
    w->simplex = w->items[i].simplex;
    w->k = w->items[i].k;
    w->cell = w->items[i].cell;
}

static void pbwio__row(pbwio__writer *w, const char *s)
{
    if (w->rows++ % 4096 == 0 && !w->cancelled) {
        const double done = (double)w->rows / (double)(w->all_rows + 1);
        w->cancelled = pbwio__stops(w->output->build, done < 1 ? done : 1);
    }
    while (*s != '\n') {
        s = pbwio__directive(w, s);
    }
    pbwio__end_line(w);
}

/* Rows of the items from i on, before end. */
static void pbwio__item_rows(pbwio__writer *w, size_t i, size_t end, const char *row)
{
    w->text = !w->binary;
    for (; i < end && !w->cancelled; i++, w->element++) {
        pbwio__seek(w, i);
        pbwio__row(w, row);
    }
}

/* Writes a row for each thing of that kind. */
static void pbwio__rows(pbwio__writer *w, char kind, const char *row)
{
    int facets = kind == 'f' || kind == 'h' || (kind == 's' && w->corners == 4);
    w->text = !w->binary;
    pbwio__rewind(w);
    if (kind == '1') {
        pbwio__row(w, row);
    } else if (kind == 'e' || (kind == 'f' && w->items != NULL)) {
        const int part = kind == 'e' ? PBWIO__EDGES : PBWIO__FACETS;
        pbwio__item_rows(w, w->first[part], w->first[part + 1], row);
    } else if (strchr("pbn", kind) == NULL) {
        for (; !w->cancelled && pbwio__step(w, facets); w->element++) {
            pbwio__row(w, row);
        }
    } else if ((kind != 'n' || w->normals != NULL) && (kind != 'b' || w->boundary != NULL)) {
        for (w->point = 0; w->point < w->mesh->point_count && !w->cancelled; w->point++) {
            if ((w->number == NULL || w->number[w->point] != PBW_NONE) && (kind != 'b' || w->boundary[w->point])) {
                pbwio__row(w, row);
            }
        }
    }
}

static void pbwio__print_form(pbwio__writer *w, const char *form)
{
    while (*form != 0) {
        w->text = 1;
        if (*form == '@') {
            pbwio__rows(w, form[1], form + 2);
            form = strchr(form, '\n') + 1;
        } else {
            form = pbwio__directive(w, form);
        }
    }
    w->text = !w->binary;
}

/* ------------------------------------------------------------------------------------------------------
   >>groups       Regions, patches, edges and points as entities of their own.
   In: the caller's groups of elements.  Out: items.
   Holds: items are sorted by parts and groups, so that each group is a run of them.
   ------------------------------------------------------------------------------------------------------ */

static int pbwio__compare_items(const void *a, const void *b)
{
    const pbwio__item *x = (const pbwio__item *)a, *y = (const pbwio__item *)b;
    return x->group != y->group ? (x->group > y->group) - (x->group < y->group)
         : x->inside != y->inside ? (x->inside > y->inside) - (x->inside < y->inside)
         : x->outside != y->outside ? (x->outside > y->outside) - (x->outside < y->outside)
         : x->cell != y->cell ? (x->cell > y->cell) - (x->cell < y->cell) : (x->k > y->k) - (x->k < y->k);
}

/* The region of a simplex, below PBW_NONE also if it has none. */
static pbw_index pbwio__region_of(const pbwio__writer *w, size_t simplex)
{
    const pbw_index region = w->output->regions != NULL ? w->output->regions[simplex] : 0;
    return region == PBW_NONE ? PBW_NONE - 1 : region;
}

/* Fills in facet k of the simplex at hand, or the simplex itself, k = corners.  Returns whether it is written: facets
   on the hull, and inside those between regions and, of the caller's groups, those in one. */
static int pbwio__make_item(const pbwio__writer *w, size_t k, int hull_only, pbwio__item *item)
{
    const pbwio_output *o = w->output;
    const size_t at = w->corners * w->simplex + k;
    const int facet = k < w->corners, hull = facet && pbwio__on_hull(w, w->simplex, k);
    pbw_index next;
    item->simplex = w->simplex;
    item->k = k;
    item->cell = w->cell;
    item->inside = pbwio__region_of(w, w->simplex);
    item->outside = PBW_NONE;
    item->group = !facet ? item->inside : o->patches != NULL ? o->patches[at] : !hull;
    if (hull && o->groups != NULL && item->group == PBW_NONE
        && (o->format == PBWIO_MSH || o->format == PBWIO_MSH2 || o->format == PBWIO_VTU)) {
        return 0;                                                    /* Gmsh does not write what is in no group */
    }
    if (!facet || hull || w->mesh->neighbors == NULL || hull_only) {
        return !facet || hull;
    }
    next = w->mesh->neighbors[at];
    item->outside = pbwio__region_of(w, next);
    if (item->inside == item->outside) {
        return o->groups != NULL && o->patches != NULL && item->group != PBW_NONE && w->simplex < next;
    }
    return item->inside < item->outside && (o->groups == NULL || o->patches == NULL || item->group != PBW_NONE);
}

/* Sorts items, and tells the first of each run where that ends. */
static void pbwio__sort_items(pbwio__item *items, size_t from, size_t to)
{
    size_t i, first;
    if (from < to) {
        qsort(items + from, to - from, sizeof *items, pbwio__compare_items);
    }
    for (first = i = from; i < to; i++) {
        if (items[i].group != items[first].group || items[i].inside != items[first].inside
            || items[i].outside != items[first].outside) {
            first = i;
        }
        items[first].end = i + 1;
    }
}

/* Fills in edge or point i of the caller's.  Returns whether the file has it: its points, and points in groups. */
static int pbwio__make_mark(const pbwio__writer *w, int part, size_t i, pbwio__item *item)
{
    const pbwio_output *o = w->output;
    const pbw_index *groups = part == PBWIO__EDGES ? o->edge_groups : o->point_groups;
    const size_t a = part == PBWIO__EDGES ? o->edges[2 * i] : i, b = part == PBWIO__EDGES ? o->edges[2 * i + 1] : i;
    item->simplex = item->cell = i;
    item->k = w->corners + (part == PBWIO__EDGES ? 1 : 2);
    item->inside = item->outside = 0;
    item->group = groups != NULL ? groups[i] : 0;
    return (part == PBWIO__EDGES || item->group != PBW_NONE)
        && (w->number == NULL || (w->number[a] != PBW_NONE && w->number[b] != PBW_NONE));
}

/* Lists and sorts all parts.  Returns whether there is memory. */
static int pbwio__list_items(pbwio__writer *w, int hull_only)
{
    const size_t marks[] = { w->dim == 3 && w->output->edges != NULL ? w->output->edge_count : 0,
                             w->output->point_groups != NULL ? w->mesh->point_count : 0 };
    pbwio__item item;
    size_t count[PBWIO__PARTS], i, k;
    int fill, part;
    for (fill = 0; fill < 2; fill++) {
        for (part = 0; part < PBWIO__PARTS; part++) {
            w->first[part + 1] = w->first[part] + (fill ? count[part] : 0);
            count[part] = 0;
        }
        i = w->first[PBWIO__PARTS] + 1;
        if (fill && !pbw_memory_fit(&w->memory, &w->items, &w->item_capacity, i, sizeof item)) {
            return 0;
        }
        pbwio__rewind(w);
        while (pbwio__step(w, 0)) {
            for (k = 0; k <= w->corners; k++) {
                part = k < w->corners ? PBWIO__FACETS : PBWIO__CELLS;
                if (pbwio__make_item(w, k, hull_only, &item)) {
                    i = w->first[part] + count[part]++;
                    *(fill ? w->items + i : &item) = item;
                }
            }
        }
        for (part = PBWIO__EDGES; part < PBWIO__PARTS; part++) {
            for (k = 0; k < marks[part - PBWIO__EDGES]; k++) {
                if (pbwio__make_mark(w, part, k, &item)) {
                    i = w->first[part] + count[part]++;
                    *(fill ? w->items + i : &item) = item;
                }
            }
        }
    }
    w->facet_count = count[PBWIO__FACETS];
    for (part = 0; part < PBWIO__PARTS; part++) {
        pbwio__sort_items(w->items, w->first[part], w->first[part + 1]);
    }
    return 1;
}

/* The part that item i is in. */
static int pbwio__part_of(const pbwio__writer *w, size_t i)
{
    int part = 0;
    while (i >= w->first[part + 1]) {
        part++;
    }
    return part;
}

/* Where the run of items that starts at i ends; whole: of one group, whatever its regions. */
static size_t pbwio__run(const pbwio__writer *w, size_t i, int whole)
{
    const size_t end = w->first[pbwio__part_of(w, i) + 1];
    const pbw_index group = w->items[i].group;
    do {
        i = w->items[i].end;
    } while (whole && i < end && w->items[i].group == group);
    return i;
}

static size_t pbwio__runs(const pbwio__writer *w, int part, int whole)
{
    size_t i, count = 0;
    for (i = w->first[part]; i < w->first[part + 1]; i = pbwio__run(w, i, whole)) {
        count++;
    }
    return count;
}

/* Writes a name; word: with an underscore for all but letters, digits, points and hyphens. */
static void pbwio__put_name(pbwio__writer *w, const char *name, int word)
{
    for (; *name != 0; name++) {
        const int letter = pbwio__lower(*name) >= 'a' && pbwio__lower(*name) <= 'z';
        const int fits = word ? letter || (*name >= '0' && *name <= '9') || *name == '-' || *name == '.'
                       : *name != '"' && (unsigned char)*name >= ' ';
        pbwio__put(w, fits ? name : "_", 1);
    }
}

/* The parts in the order of .msh, which is that of dimensions. */
static const int pbwio__in_order[] = { PBWIO__MARKED, PBWIO__EDGES, PBWIO__FACETS, PBWIO__CELLS };

/* The name of a group as a word, made of its tag if it has none, and the end of the line. */
static void pbwio__put_group(pbwio__writer *w, const pbwio_group *group)
{
    if (group->name != NULL) {
        pbwio__put_name(w, group->name, 1);
    } else if (group->tag != 0) {
        pbwio__print(w, "group_%lld", group->tag);
    } else {
        pbwio__print(w, "ungrouped");
    }
    pbwio__print(w, "\n");
}

/* ------------------------------------------------------------------------------------------------------
   >>words        Names of groups as words, for .inp and .su2.
   In: the caller's groups.  Out: words, one a group.
   Holds: no two names of one kind, and no name and a word that the format has anyway, become the same word.
   ------------------------------------------------------------------------------------------------------ */

/* The group that all simplices are in, PBW_NONE if there is none. */
static pbw_index pbwio__only_region(const pbw_mesh *mesh, const pbwio_output *o)
{
    pbw_index only = PBW_NONE;
    size_t i, count = 0;
    for (i = 0; o->regions != NULL && i < mesh->simplex_count; i++) {
        if (o->keep == NULL || o->keep[i]) {
            only = count++ == 0 || only == o->regions[i] ? o->regions[i] : PBW_NONE;
            if (only == PBW_NONE) {
                break;
            }
        }
    }
    return only;
}

/* The group that all facets of the hull are in, and no others, PBW_NONE if there is none. */
static pbw_index pbwio__only_patch(const pbw_mesh *mesh, const pbwio_output *o)
{
    const size_t n = (size_t)mesh->dim + 1;
    pbw_index only = PBW_NONE;
    size_t i, count = 0;
    int inner;
    for (inner = 0; inner < 2; inner++) {
        for (i = 0; o->patches != NULL && mesh->neighbors != NULL && i < n * mesh->simplex_count; i++) {
            const pbw_index next = mesh->neighbors[i], patch = o->patches[i];
            const int inside = next != PBW_NONE && (o->keep == NULL || o->keep[next]);
            if (inside != inner || (o->keep != NULL && !o->keep[i / n])) {
                continue;
            }
            only = !inner && count++ == 0 ? patch : only;
            if ((patch == only) == inner) {
                return PBW_NONE;
            }
        }
    }
    return only;
}

/* The groups of the caller's that are called as what .inp has anyway, and are the same: by parts. */
static void pbwio__find_builtin(const pbw_mesh *mesh, const pbwio_output *o, size_t corners, pbw_index builtin[2])
{
    static const char *const names[] = { "BOUNDARY", "DOMAIN" };
    int part;
    builtin[PBWIO__CELLS] = pbwio__only_region(mesh, o);
    builtin[PBWIO__FACETS] = corners == (size_t)mesh->dim + 1 ? pbwio__only_patch(mesh, o) : PBW_NONE;
    for (part = 0; part < 2; part++) {
        const char *name = builtin[part] < o->group_count ? o->groups[builtin[part]].name : NULL;
        if (name == NULL || !pbwio__same(name, strlen(name), names[part], strlen(names[part]))) {
            builtin[part] = PBW_NONE;
        }
    }
}

/* The kind of names in .inp: sets of elements, or of nodes and surfaces; in .su2 those of facets, 0 for others. */
static int pbwio__word_kind(pbwio_format format, int corners, int dim)
{
    return format == PBWIO_SU2 ? (dim == corners - 2 ? 's' : 0) : dim == corners - 1 ? 'e' : 's';
}

/* The slot of a word in a table, or the free slot for it. */
static size_t pbwio__word_slot(char *const *words, const int *kinds, const pbw_index *table, size_t size, int kind,
                               const char *word)
{
    pbwio__field name;
    size_t at;
    name.begin = word;
    name.end = word + strlen(word);
    for (at = (size_t)pbwio__set_hash(kind, name) & (size - 1); table[at] != PBW_NONE; at = (at + 1) & (size - 1)) {
        if (kinds[table[at]] == kind && pbwio__is(name, words[table[at]])) {
            break;
        }
    }
    return at;
}

/* The names of groups as words of letters, digits, points, hyphens and underscores, group_TAG of those without a
   name.  Of names that become one word, whatever the case of letters, or a word that files have anyway, the later
   ones end with _2, _3 and so on.  builtin: as in the writer.  One block of *bytes; NULL: no memory. */
static char **pbwio__make_words(pbw_memory *memory, const pbwio_output *o, int corners, const pbw_index builtin[2],
                                size_t *bytes)
{
    static const char *const taken[] = { "BOUNDARY", "DOMAIN", "NALL", "ungrouped" };
    const size_t n = o->group_count + 4;
    size_t size = 8, length = 0, i, at;
    char **words, *text;
    int *kinds, *last;                               /* last: the number behind the last word made of this one */
    pbw_index *table;
    for (i = 0; i < o->group_count; i++) {
        length += (o->groups[i].name != NULL ? strlen(o->groups[i].name) : 0) + 48;
    }
    for (; size < 2 * n; size *= 2) {
    }
    *bytes = n * (sizeof *words + 2 * sizeof *kinds) + size * sizeof *table + length;
    words = (char **)pbw_memory_resize(memory, NULL, 0, *bytes, 1);
    if (words == NULL) {
        return NULL;
    }
    kinds = (int *)(void *)(words + n);
    last = kinds + n;
    table = (pbw_index *)(void *)(last + n);
    text = (char *)(table + size);
    memset(table, 0xff, size * sizeof *table);
    for (i = n; i-- > o->group_count;) {             /* behind the groups: words that are taken */
        const size_t k = i - o->group_count;
        words[i] = (char *)(uintptr_t)taken[k];
        kinds[i] = o->format == PBWIO_SU2 ? (k == 3 ? 's' : 0) : k == 3 ? 0 : k == 1 ? 'e' : 's';
        last[i] = 1;
        if (kinds[i] != 0 && (k > 1 || builtin[k] == PBW_NONE)) {
            table[pbwio__word_slot(words, kinds, table, size, kinds[i], words[i])] = (pbw_index)i;
        }
    }
    for (i = 0; i < o->group_count; i++) {
        const char *s = o->groups[i].name;
        char *end = text;
        words[i] = text;
        kinds[i] = pbwio__word_kind(o->format, corners, o->groups[i].dim);
        last[i] = 1;
        for (; s != NULL && *s != 0; s++) {
            const int c = pbwio__lower(*s);
            *end++ = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.' ? *s : '_';
        }
        end += end == text ? sprintf(end, "group_%lld", o->groups[i].tag) : 0;
        *end = 0;
        at = pbwio__word_slot(words, kinds, table, size, kinds[i], text);
        if (table[at] != PBW_NONE && kinds[i] != 0) {
            int *number = last + table[at];
            do {
                sprintf(end, "_%d", ++*number);
                at = pbwio__word_slot(words, kinds, table, size, kinds[i], text);
            } while (table[at] != PBW_NONE);
        }
        table[at] = (pbw_index)i;
        text += strlen(text) + 1;
    }
    return words;
}

/* ------------------------------------------------------------------------------------------------------
   >>files        Files with groups: .msh .obj .stl .inp .su2 .vtu.
   In: items in runs.  Out: the text or bytes of a file.
   Holds: w->text tells how the next value is written; elements are numbered in the order in which they are written.
   ------------------------------------------------------------------------------------------------------ */

/* $PhysicalNames of the groups of the caller's that have a name, and of the default groups that are written. */
static void pbwio__write_names(pbwio__writer *w)
{
    const pbwio_output *o = w->output;
    const pbw_index *const given[] = { o->patches, o->regions, o->edge_groups, o->point_groups };
    size_t i, count = 0;
    pbwio_group group;
    int pass, part, n;
    for (pass = 0; pass < 2; pass++) {
        if (pass == 1) {
            pbwio__print(w, "$PhysicalNames\n%zu\n", count);
        }
        for (i = 0; o->groups != NULL && i < o->group_count; i++) {
            group = pbwio__caller_group(w, (pbw_index)i);
            count += group.name != NULL;
            if (pass == 1 && group.name != NULL) {
                pbwio__print(w, "%d %lld \"", group.dim, group.tag);
                pbwio__put_name(w, group.name, 0);
                pbwio__print(w, "\"\n");
            }
        }
        for (n = 0; n < PBWIO__PARTS; n++) {
            part = pbwio__in_order[n];
            for (i = w->first[part]; i < w->first[part + 1]; i = pbwio__run(w, i, 1)) {
                if (o->groups == NULL || (given[part] == NULL && o->group_count > 0)) {
                    pbwio__seek(w, i);
                    group = pbwio__group(w);
                    count++;
                    if (pass == 1) {
                        pbwio__print(w, "%d %lld \"%s\"\n", group.dim, group.tag, group.name);
                    }
                }
            }
        }
    }
    pbwio__print(w, "$EndPhysicalNames\n");
}

/* An entity: tag, place or box, its physical group if it has one; the caller adds what bounds it. */
static void pbwio__write_entity(pbwio__writer *w, size_t tag, const double *box, int numbers)
{
    const pbwio_group group = pbwio__group(w);
    int k;
    pbwio__int(w, (long long)tag, 4);
    for (k = 0; k < numbers; k++) {
        pbwio__real(w, box[k]);
    }
    pbwio__int(w, group.tag != 0, 8);
    if (group.tag != 0) {
        pbwio__int(w, group.tag, 4);
    }
}

/* The entities that bound a region: those of facets with it on a side, negative where they turn into it. */
static void pbwio__write_bounds(pbwio__writer *w, pbw_index region)
{
    size_t i, count = 0;
    int pass, tag;
    for (pass = 0; pass < 2; pass++) {
        if (pass == 1) {
            pbwio__int(w, (long long)count, 8);
        }
        for (i = 0, tag = 1; i < w->first[PBWIO__CELLS]; i = pbwio__run(w, i, 0), tag++) {
            const int inside = w->items[i].inside == region, outside = w->items[i].outside == region;
            count += inside || outside;
            if (pass == 1 && (inside || outside)) {
                pbwio__int(w, inside ? tag : -tag, 4);
            }
        }
    }
}

static void pbwio__write_entities(pbwio__writer *w)
{
    size_t count[4] = { 0, 0, 0, 0 }, i, k, tag;
    double box[6];
    int part, n;
    for (i = 0; i < 6; i++) {
        box[i] = pbwio__extreme(w, i % 3, i < 3 ? 1 : -1);
    }
    count[0] = w->first[PBWIO__PARTS] - w->first[PBWIO__MARKED];
    count[1] = pbwio__runs(w, PBWIO__EDGES, 0);
    count[w->corners - 2] += pbwio__runs(w, PBWIO__FACETS, 0);
    count[w->corners - 1] = pbwio__runs(w, PBWIO__CELLS, 0);
    pbwio__print(w, "$Entities\n");
    w->text = !w->binary;
    for (i = 0; i < 4; i++) {
        pbwio__int(w, (long long)count[i], 8);
    }
    pbwio__end_line(w);
    for (n = 0; n < PBWIO__PARTS; n++) {
        part = pbwio__in_order[n];
        for (i = w->first[part], tag = 1; i < w->first[part + 1]; tag++) {
            pbwio__seek(w, i);
            if (part == PBWIO__MARKED) {
                double place[3] = { 0, 0, 0 };
                for (k = 0; k < w->dim; k++) {
                    place[k] = w->mesh->points[w->dim * w->simplex + k];
                }
                pbwio__write_entity(w, tag, place, 3);
                i++;
            } else {
                pbwio__write_entity(w, tag, box, 6);
                if (part == PBWIO__CELLS) {
                    pbwio__write_bounds(w, w->items[i].inside);
                } else {
                    pbwio__int(w, 0, 8);
                }
                i = pbwio__run(w, i, 0);
            }
            pbwio__end_line(w);
        }
    }
    w->text = 1;
    pbwio__print(w, "%s$EndEntities\n$Nodes\n", w->binary ? "\n" : "");
    w->text = !w->binary;
}

/* The head of a block of elements or, with type 0, of points. */
static void pbwio__write_block(pbwio__writer *w, size_t dim, size_t tag, int type, size_t count)
{
    w->text = !w->binary;
    pbwio__int(w, (long long)dim, 4);
    pbwio__int(w, (long long)tag, 4);
    pbwio__int(w, type, 4);
    pbwio__int(w, (long long)count, 8);
    pbwio__end_line(w);
}

/* .msh with groups: every point is in the first region's entity. */
static void pbwio__write_msh(pbwio__writer *w)
{
    static const unsigned char types[] = { 15, 1, 2, 4 };
    const size_t all = w->first[PBWIO__PARTS];
    size_t i, end, tag, blocks, dim;
    int n, part;
    pbwio__print_form(w, "$MeshFormat\n4.1 [t0][b1] 8\n[b@1#1\n\n]$EndMeshFormat\n");
    pbwio__write_names(w);
    pbwio__write_entities(w);
    pbwio__print_form(w, "@1&1%n&1%n\n");
    pbwio__write_block(w, w->corners - 1, 1, 0, w->point_count);
    pbwio__print_form(w, "@p%i\n@p%X\n[b\n]$EndNodes\n$Elements\n");
    w->text = !w->binary;
    blocks = all - w->first[PBWIO__MARKED] + pbwio__runs(w, PBWIO__EDGES, 0) + pbwio__runs(w, PBWIO__FACETS, 0)
           + pbwio__runs(w, PBWIO__CELLS, 0);
    pbwio__int(w, (long long)blocks, 8);
    pbwio__int(w, (long long)all, 8);
    pbwio__int(w, 1, 8);
    pbwio__int(w, (long long)all, 8);
    pbwio__end_line(w);
    for (n = 0; n < PBWIO__PARTS; n++) {
        part = pbwio__in_order[n];
        dim = part == PBWIO__MARKED ? 0 : part == PBWIO__EDGES ? 1
            : w->corners - 1 - (part == PBWIO__FACETS);
        for (i = w->first[part], tag = 1; i < w->first[part + 1]; i = end, tag++) {
            end = part == PBWIO__MARKED ? i + 1 : pbwio__run(w, i, 0);
            pbwio__write_block(w, dim, tag, types[dim], end - i);
            pbwio__item_rows(w, i, end, "%j%v\n");
        }
    }
    pbwio__print_form(w, "[b\n]$EndElements\n");
}

static void pbwio__write_msh2(pbwio__writer *w)
{
    int n;
    pbwio__print(w, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    pbwio__write_names(w);
    pbwio__print_form(w, "$Nodes\n%n\n@p%i%X\n$EndNodes\n$Elements\n%e\n");
    for (n = 0; n < PBWIO__PARTS; n++) {
        const int part = pbwio__in_order[n];
        pbwio__item_rows(w, w->first[part], w->first[part + 1], "%j%T2 %P%E%v\n");
    }
    pbwio__print(w, "$EndElements\n");
}

/* Triangles of .obj and .stl by groups, those in none first. */
static void pbwio__write_triangles(pbwio__writer *w, const char *before, const char *row, const char *after)
{
    const int part = w->corners == 4 ? PBWIO__FACETS : PBWIO__CELLS;
    size_t i, end, last = w->first[part + 1];
    int none, pass;
    for (none = last > w->first[part] && w->items[last - 1].group >= w->output->group_count, pass = !none; pass < 2;
         pass++) {
        for (i = w->first[part]; i < last; i = end) {
            const pbw_index group = w->items[i].group;
            const char *name = group < w->output->group_count ? w->output->groups[group].name : "";
            end = pbwio__run(w, i, 1);
            if ((group >= w->output->group_count) != (pass == 0)) {
                continue;
            }
            w->text = 1;
            if (pass == 1 || w->output->format == PBWIO_STL) {
                pbwio__print(w, "%s", before);
                if (name == NULL) {
                    pbwio__print(w, " group_%lld", w->output->groups[group].tag);
                } else {
                    pbwio__put(w, " ", *name != 0);
                    pbwio__put_name(w, name, 0);
                }
                pbwio__print(w, "\n");
            }
            pbwio__item_rows(w, i, end, row);
            pbwio__print(w, "%s", after);
        }
    }
}

static void pbwio__write_obj(pbwio__writer *w)
{
    pbwio__print_form(w, "@pv %X\n@nvn %m\n");
    if (w->items == NULL) {
        pbwio__print_form(w, "@sf %V\n");
    } else {
        pbwio__write_triangles(w, "g", "f %V\n", "");
    }
}

#define PBWIO__STL_ROW \
    "[tfacet normal ]%N|[touter loop|vertex ]%0|[tvertex ]%1|[tvertex ]%2|[tendloop|endfacet][b%z]\n"

static void pbwio__write_stl(pbwio__writer *w)
{
    if (w->items == NULL || w->binary) {
        pbwio__print_form(w, "[tsolid triangles\n][b       binary STL, triangles                    "
                          "                                ][b@1%s\n]@s" PBWIO__STL_ROW "[tendsolid triangles\n]");
    } else {
        pbwio__write_triangles(w, "solid", PBWIO__STL_ROW, "endsolid\n");
    }
}

/* The points of the items from i on, before end, each once: mark holds the last list that has it. */
static void pbwio__write_points(pbwio__writer *w, size_t i, size_t end, pbw_index *mark)
{
    const pbw_index list = (pbw_index)i;
    pbw_index corner[4];
    size_t count;
    for (; i < end; i++) {
        pbwio__seek(w, i);
        for (count = pbwio__corners(w, corner); count-- > 0;) {
            if (mark[corner[count]] != list) {
                mark[corner[count]] = list;
                pbwio__int(w, pbwio__number_of(w, corner[count]), 8);
                pbwio__end_line(w);
            }
        }
    }
}

#define PBWIO__SIDE_ROW "%p[3S%k][2[ZS%k][zE%k]]"      /* edges of shells are E1 to E3 */

/* .inp: an ELSET for each region; for each patch a SURFACE and an NSET of its points; an NSET of the points of each
   group of edges and points.  w->number has room for marks behind the numbers. */
static void pbwio__write_inp(pbwio__writer *w)
{
    const pbwio_output *o = w->output;
    const size_t points = w->mesh->point_count;
    pbw_index *mark = w->number + points;
    pbwio_group group;
    size_t i, end;
    int part;
    memset(mark, 0xff, points * sizeof *mark);
    for (part = 0; part < PBWIO__PARTS; part++) {
        if (part == PBWIO__CELLS ? o->regions == NULL
            : part == PBWIO__FACETS && o->patches == NULL && o->regions == NULL) {
            continue;                                                /* DOMAIN, BOUNDARY */
        }
        for (i = w->first[part]; i < w->first[part + 1]; i = end) {
            end = pbwio__run(w, i, 1);
            pbwio__seek(w, i);
            group = pbwio__group(w);
            if (group.tag == 0 || (part == PBWIO__FACETS && o->patches == NULL && w->items[i].group == 0)
                || (o->groups != NULL && part <= PBWIO__CELLS && w->items[i].group == w->builtin[part])) {
                continue;
            }
            pbwio__print(w, part == PBWIO__CELLS ? "*ELSET, ELSET=" : "*NSET, NSET=");
            pbwio__put_group(w, &group);
            if (part == PBWIO__CELLS) {
                pbwio__item_rows(w, i, end, "%p\n");
            } else {
                pbwio__write_points(w, i, end, mark);
            }
            if (part == PBWIO__FACETS) {
                pbwio__print(w, "*SURFACE, TYPE=ELEMENT, NAME=");
                pbwio__put_group(w, &group);
                pbwio__item_rows(w, i, end, PBWIO__SIDE_ROW "\n");
            }
        }
    }
}

/* .su2: a marker for each patch of the hull. */
static void pbwio__write_su2(pbwio__writer *w)
{
    const char *row = w->corners == 4 ? "5 %v\n" : "3 %v\n";
    size_t i, end;
    pbwio__print_form(w, "NDIME= %d\nNELEM= %c\n@c[25][310] %v\nNPOIN= %n\n@p%y\n");
    if (w->items == NULL) {
        pbwio__print_form(w, "[fNMARK= 1\nMARKER_TAG= boundary\nMARKER_ELEMS= %f\n@f[23][35] %v\n]");
        return;
    }
    pbwio__print(w, "NMARK= %zu\n", pbwio__runs(w, PBWIO__FACETS, 1));
    for (i = 0; i < w->first[PBWIO__CELLS]; i = end) {
        pbwio_group group;
        end = pbwio__run(w, i, 1);
        pbwio__seek(w, i);
        group = pbwio__group(w);
        pbwio__print(w, "MARKER_TAG= ");
        pbwio__put_group(w, &group);
        pbwio__print(w, "MARKER_ELEMS= %zu\n", end - i);
        pbwio__item_rows(w, i, end, row);
    }
}

/* The caller's groups that have a name, as fields of the whole file: tag and dimension, as meshio has them. */
static void pbwio__write_vtu_names(pbwio__writer *w)
{
    const pbwio_output *o = w->output;
    size_t i, count = 0;
    for (i = 0; o->groups != NULL && i < o->group_count; i++) {
        if (o->groups[i].name != NULL) {
            pbwio__print(w, "%s<DataArray type=\"Int64\" Name=\"", count++ == 0 ? "<FieldData>\n" : "");
            pbwio__put_escaped(w, o->groups[i].name);
            pbwio__print(w, "\" NumberOfTuples=\"2\" format=\"ascii\">%lld %d</DataArray>\n", o->groups[i].tag,
                         o->groups[i].dim);
        }
    }
    pbwio__print(w, count > 0 ? "</FieldData>\n" : "");
}

/* The one format that is more than a form: in binary all tags come first, then all numbers. */
static void pbwio__write_vtu(pbwio__writer *w)
{
    const pbwio_output *o = w->output;
    const size_t *first = w->first;
    const size_t facets = first[PBWIO__CELLS], edges = first[PBWIO__MARKED] - first[PBWIO__EDGES];
    const size_t others = facets + edges, cells = w->cell_count + others;
    const size_t nodes = w->corners * w->cell_count + (w->corners - 1) * facets + 2 * edges;
    const struct { const char *before, *type, *name; char kind; const char *row; size_t size, is; } arrays[] = {
        { "<PointData>\n", "UInt32", "id", 'p', "%o\n", 4, 1 },
        { "", "Float64", "weight", 'p', "%w\n", 8, w->mesh->weights != NULL },
        { "", "Int64", "marker", 'p', "%M\n", 8, w->output->point_groups != NULL },
        { "", "Float64", NULL, 'p', "%K\n", 8, w->output->column_count },
        { "</PointData>\n<CellData>\n", "Float64", "quality", 'c', "%q\n", 8, 1 },
        { "", "Float64", o->value_name == NULL ? "value" : o->value_name, 'c', "%u\n", 8, o->values != NULL },
        { "", "Int64", "region", 'c', "%G\n", 8, o->regions != NULL },
        { "", "Int64", "patch", 'c', "%S\n", 8, facets > 0 },
        { "", "Int64", "edge", 'c', "%L\n", 8, edges > 0 },
        { "</CellData>\n<Points>\n", "Float64", "points", 'p', "%X\n", 24, 1 },
        { "</Points>\n<Cells>\n", "UInt32", "connectivity", 'v', "%v\n", 4, 1 },
        { "", "Int64", "offsets", 'c', "%a\n", 8, 1 },
        { "", "UInt8", "types", 'c', "%t\n", 1, 1 }
    };
    unsigned long long offset = 0;
    size_t i, bytes;
    int pass;
    pbwio__print(w, "<?xml version=\"1.0\"?>\n"
                 "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"%s\" header_type=\"UInt64\">\n"
                 "<UnstructuredGrid>\n", pbwio__little_endian() ? "LittleEndian" : "BigEndian");
    pbwio__write_vtu_names(w);
    pbwio__print(w, "<Piece NumberOfPoints=\"%zu\" NumberOfCells=\"%zu\">\n", w->point_count, cells);
    for (pass = 0; pass <= w->binary; pass++) {                      /* binary: all tags, then all numbers */
        for (i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
            bytes = arrays[i].size * (arrays[i].kind == 'p' ? w->point_count : arrays[i].kind == 'c' ? cells : nodes);
            pbwio__print(w, "%s", pass == 0 ? arrays[i].before : "");
            for (w->column = 0; w->column < arrays[i].is; w->column++) {
                if (pass == 0) {
                    pbwio__print(w, "<DataArray type=\"%s\" Name=\"%.200s", arrays[i].type,
                                 arrays[i].name != NULL ? arrays[i].name : "");
                    if (arrays[i].name == NULL) {
                        pbwio__column_name(w, w->column);
                    }
                    pbwio__print(w, "\" NumberOfComponents=\"%d\" ", arrays[i].size == 24 ? 3 : 1);
                }
                if (pass == 0 && w->binary) {
                    pbwio__print(w, "format=\"appended\" offset=\"%llu\"/>\n", offset);
                    offset += 8 + bytes;
                    continue;
                }
                if (pass == 0) {
                    pbwio__print(w, "format=\"ascii\">\n");
                } else {
                    pbwio__int(w, (long long)bytes, 8);
                }
                w->element = w->node = 0;
                pbwio__rows(w, arrays[i].kind, arrays[i].row);
                if (arrays[i].kind != 'p' && others > 0) {
                    pbwio__item_rows(w, 0, w->first[PBWIO__CELLS], arrays[i].row);
                    pbwio__item_rows(w, w->first[PBWIO__EDGES], w->first[PBWIO__MARKED], arrays[i].row);
                }
                pbwio__print(w, "%s", w->binary ? "" : "</DataArray>\n");
            }
        }
        pbwio__print(w, "%s%s", pass == 0 ? "</Cells>\n</Piece>\n</UnstructuredGrid>\n" : "\n</AppendedData>\n",
                     pass == 0 && w->binary ? "<AppendedData encoding=\"raw\">\n_" : "");
    }
    pbwio__print(w, "</VTKFile>\n");
}

/* ------------------------------------------------------------------------------------------------------
   >>formats      All formats, and what each keeps.
   In: the name of a file, or a format.  Out: its reader and its writer or form; what files of it keep and lose.
   Holds: the table has the formats in the order of pbwio_format.
   ------------------------------------------------------------------------------------------------------ */
#define PBWIO__SURFACE   1u            /* holds the hull in 3D, the triangles in 2D, and their corners only */
#define PBWIO__BINARY    2u            /* has a binary form */
#define PBWIO__FROM_1    4u            /* numbers start at 1 */
#define PBWIO__NO_ORPHANS 8u           /* for solvers, which take every point for one of the mesh */
#define PBWIO__BOUNDARY 16u            /* tells which points are on the boundary */
#define PBWIO__SIMPLICES 32u           /* numbers are of simplices */
#define PBWIO__COMMAS   64u
#define PBWIO__GROUPED 128u            /* has groups of facets and simplices */
#define PBWIO__BASE    256u            /* numbers start where the caller wants */
#define PBWIO__HULL    512u            /* of facets, those of the hull only */

#define PBWIO__ALL_GROUPS ((unsigned)(PBWIO_REGIONS | PBWIO_PATCHES | PBWIO_INNER_PATCHES | PBWIO_EDGES \
                                      | PBWIO_MARKS | PBWIO_NAMES))

#define PBWIO__GROUPS "$PhysicalNames\n2\n[21][32] 1 \"boundary\"\n[22][33] 2 \"domain\"\n$EndPhysicalNames\n"

typedef struct pbwio__format_info {
    const char *endings;               /* of names */
    unsigned traits, keeps;            /* keeps: as pbwio_keeps */
    void (*read)(pbwio__reader *r);    /* NULL: it is not read */
    void (*write)(pbwio__writer *w);   /* NULL: by its form */
    const char *form;
} pbwio__format_info;

static const pbwio__format_info pbwio__format_table[] = {
    { "", 0, 0, NULL, NULL, NULL },
    { "obj", PBWIO__SURFACE | PBWIO__FROM_1 | PBWIO__GROUPED | PBWIO__HULL, PBWIO_NAMES | PBWIO_HEIGHTS,
      pbwio__read_obj, pbwio__write_obj, NULL },
    { "ply", PBWIO__SURFACE | PBWIO__BINARY, PBWIO_COLUMNS | PBWIO_HEIGHTS, pbwio__read_ply, NULL,
      "ply\nformat [tascii][lbinary_little_endian][gbinary_big_endian] 1.0\n"
      "element vertex %n\nproperty double x\nproperty double y\nproperty double z\n"
      "[mproperty double nx\nproperty double ny\nproperty double nz\n]%H"
      "[selement face %s\nproperty list uchar int vertex_indices\n]end_header\n@p%X%m%C\n@s[t3 ][b\3]%v\n" },
    { "stl", PBWIO__SURFACE | PBWIO__BINARY | PBWIO__GROUPED | PBWIO__HULL, PBWIO_NAMES | PBWIO_HEIGHTS,
      pbwio__read_stl, pbwio__write_stl, NULL },
    { "off", PBWIO__SURFACE, PBWIO_HEIGHTS, pbwio__read_off, NULL, "OFF\n%n%s0\n@p%X\n@s3 %v\n" },
    { "node", PBWIO__BOUNDARY | PBWIO__BASE, PBWIO_MARKS | PBWIO_COLUMNS | PBWIO_HEIGHTS | PBWIO_WEIGHTS,
      pbwio__read_node, NULL, "%n%d%A1\n@p%i%y%w%C%h%b\n" },
    { "xyz txt pts asc dat tsv", 0, PBWIO_HEIGHTS | PBWIO_WEIGHTS, pbwio__read_table, NULL, "@p%x%w%m\n" },
    { "csv", PBWIO__COMMAS, PBWIO_MARKS | PBWIO_COLUMNS | PBWIO_HEIGHTS | PBWIO_WEIGHTS, pbwio__read_table, NULL,
      "x,y[z,z][w,weight][m,nx,ny,nz]%H[M,marker]\n@p%x%w%m%C[M%M]\n" },
    { "vtu", PBWIO__BINARY | PBWIO__GROUPED, PBWIO__ALL_GROUPS | PBWIO_COLUMNS | PBWIO_HEIGHTS | PBWIO_WEIGHTS,
      pbwio__read_vtu, pbwio__write_vtu, NULL },
    /* Entity 1 of dimension dim-1 is the boundary, entity 1 of dimension dim the domain with all points: tag, box,
       physical groups, entities that bound it.  Blocks start with dimension, entity, type, count. */
    { "msh", PBWIO__BINARY | PBWIO__FROM_1 | PBWIO__GROUPED, PBWIO__ALL_GROUPS | PBWIO_HEIGHTS, pbwio__read_msh, NULL,
      "$MeshFormat\n4.1 [t0][b1] 8\n[b@1#1\n\n]$EndMeshFormat\n" PBWIO__GROUPS
      "$Entities\n@1&0[2&1][3&0]&1[2&0][3&1]\n@1#1%B&1#1&0\n@1#1%B&1#2&1#1\n[b\n]$EndEntities\n"
      "$Nodes\n@1&1%n&1%n\n@1%d#1#0%n\n@p%i\n@p%X\n[b\n]$EndNodes\n"
      "$Elements\n@1[f&2][F&1]%e&1%e\n[f@1[2#1][3#2]#1[2#1][3#2]%f\n@f%j%v\n]@1%d#1[2#2][3#4]%c\n@c%j%v\n"
      "[b\n]$EndElements\n" },
    { "mesh", PBWIO__FROM_1 | PBWIO__GROUPED, (PBWIO__ALL_GROUPS & ~(unsigned)PBWIO_NAMES) | PBWIO_HEIGHTS,
      pbwio__read_medit, NULL,
      "MeshVersionFormatted 2\nDimension %D\nVertices\n%n\n@p%x%M\n[eEdges\n%l\n@e%v%P\n]"
      "[f[2Edges][3Triangles]\n%f\n@f%v%P\n][2Triangles][3Tetrahedra]\n%c\n@c%v%P\nEnd\n" },
    { "ele", PBWIO__BASE, PBWIO_REGIONS, pbwio__read_ele, NULL, "%c[23][34] [a1][A0]\n@c%j%v[a%P]\n" },
    { "neigh", PBWIO__SIMPLICES | PBWIO__BASE, 0, NULL, NULL, "%c[23][34]\n@c%j%g\n" },
    { "face edge", PBWIO__BASE | PBWIO__GROUPED, PBWIO_PATCHES | PBWIO_INNER_PATCHES, pbwio__read_facets, NULL,
      "%f1\n@f%j%v%P\n" },
    { "msh2", PBWIO__FROM_1 | PBWIO__GROUPED, PBWIO__ALL_GROUPS | PBWIO_HEIGHTS, pbwio__read_msh, NULL,
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" PBWIO__GROUPS
      "$Nodes\n%n\n@p%i%X\n$EndNodes\n"
      "$Elements\n%e\n@f%j[21][32] 2 1 1 %v\n@c%j[22][34] 2 2 1 %v\n$EndElements\n" },
    { "inp", PBWIO__FROM_1 | PBWIO__NO_ORPHANS | PBWIO__BOUNDARY | PBWIO__COMMAS | PBWIO__GROUPED,
      (PBWIO__ALL_GROUPS & ~(unsigned)PBWIO_EDGES) | PBWIO_HEIGHTS, pbwio__read_inp, NULL,
      "*NODE, NSET=NALL\n@p%i%x\n*ELEMENT, TYPE=[2[ZCPS3][zS3]][3C3D4], ELSET=DOMAIN\n@c%j%v\n"
      "[f*NSET, NSET=BOUNDARY\n@b%i\n*SURFACE, NAME=BOUNDARY, TYPE=ELEMENT\n@h" PBWIO__SIDE_ROW "\n]" },
    { "su2", PBWIO__NO_ORPHANS | PBWIO__GROUPED | PBWIO__HULL, PBWIO_PATCHES | PBWIO_NAMES, pbwio__read_su2,
      pbwio__write_su2, NULL },
    { "json geojson", 0, 0, pbwio__read_json, NULL, NULL },
    { "vtk", 0, 0, pbwio__read_vtk, NULL, NULL },
    { "poly smesh", 0, 0, pbwio__read_poly, NULL, NULL }
};
enum { PBWIO__FORMATS = sizeof pbwio__format_table / sizeof pbwio__format_table[0] };

static const pbwio__format_info *pbwio__info_of(pbwio_format format)
{
    return pbwio__format_table + ((size_t)format < PBWIO__FORMATS ? (size_t)format : 0);
}

PBWDEF pbwio_format pbwio_format_of(const char *path)
{
    const pbwio__field ending = pbwio__ending(path);
    size_t i;
    for (i = 1; i < PBWIO__FORMATS; i++) {
        if (pbwio__lists(pbwio__format_table[i].endings, ending)) {
            return (pbwio_format)i;
        }
    }
    return PBWIO_AUTO;
}

PBWDEF unsigned pbwio_keeps(pbwio_format format, int corners, unsigned flags)
{
    const unsigned keeps = pbwio__info_of(format)->keeps;
    const int groups = format == PBWIO_OBJ || (format == PBWIO_STL && flags & PBWIO_TEXT);
    return format == PBWIO_STL && !groups ? keeps & ~(unsigned)PBWIO_NAMES
         : groups ? keeps | (corners == 3 ? (unsigned)PBWIO_REGIONS : (unsigned)PBWIO_PATCHES) : keeps;
}

/* Whether a group has a name that is not made of its number. */
static int pbwio__is_named(const pbwio_group *group)
{
    static const char *const made[] = { "region_", "patch_", "group_" };
    const char *name = group->name;
    size_t i;
    for (i = 0; i < 3 && name != NULL; i++) {
        const size_t length = strlen(made[i]);
        if (strncmp(name, made[i], length) == 0 && name[length + strspn(name + length, "0123456789")] == 0) {
            return 0;
        }
    }
    return name != NULL;
}

/* Whether numbers of groups say anything: an element is in one with a name, or two are in different ones. */
static int pbwio__distinguishes(const pbwio_output *o, pbw_index number, pbw_index *first, size_t *count)
{
    const int differs = (*count)++ > 0 && number != *first;
    *first = *count == 1 ? number : *first;
    return differs || (o->groups != NULL && number < o->group_count && pbwio__is_named(o->groups + number));
}

/* Which groups there are, as bits of PBWIO_REGIONS to PBWIO_MARKS; n corners. */
static unsigned pbwio__groups_of(size_t n, const pbw_mesh *mesh, const pbwio_output *o)
{
    unsigned has = o->edges != NULL && o->edge_count > 0 ? (unsigned)PBWIO_EDGES : 0;
    size_t i, count[3] = { 0, 0, 0 };
    pbw_index first[3] = { 0, 0, 0 };
    for (i = 0; o->regions != NULL && i < mesh->simplex_count && !(has & PBWIO_REGIONS); i++) {
        has |= (o->keep == NULL || o->keep[i]) && pbwio__distinguishes(o, o->regions[i], first, count)
             ? (unsigned)PBWIO_REGIONS : 0;
    }
    for (i = 0; o->patches != NULL && mesh->neighbors != NULL && i < n * mesh->simplex_count; i++) {
        const int hull = mesh->neighbors[i] == PBW_NONE || (o->keep != NULL && !o->keep[mesh->neighbors[i]]);
        if ((o->keep == NULL || o->keep[i / n]) && (hull || o->groups != NULL)
            && pbwio__distinguishes(o, o->patches[i], first + 1 + hull, count + 1 + hull)) {
            has |= hull ? (unsigned)PBWIO_PATCHES : (unsigned)PBWIO_INNER_PATCHES;
        }
    }
    for (i = 0; o->point_groups != NULL && i < mesh->point_count && !(has & PBWIO_MARKS); i++) {
        has |= o->point_groups[i] != PBW_NONE ? (unsigned)PBWIO_MARKS : 0;
    }
    return has;
}

static void pbwio__append(char *text, size_t size, const char *what)
{
    const size_t used = strlen(text);
    snprintf(text + used, size - used, "%s%s", used > 0 ? ", " : "", what);
}

PBWDEF void pbwio_losses(unsigned keeps, int corners, const pbw_mesh *mesh, const pbwio_output *output, char *text,
                         size_t size)
{
    const char *const words[] = { corners <= mesh->dim ? "groups of triangles" : "regions", "patches",
                                  "patches inside", "edges", "markers of points" };
    const unsigned has = pbwio__groups_of((size_t)corners, mesh, output);
    size_t i, named = 0;
    text[0] = 0;
    for (i = 0; i < 5; i++) {
        if (has >> i & ~keeps >> i & 1) {
            pbwio__append(text, size, words[i]);
        }
    }
    for (i = 0; output->groups != NULL && i < output->group_count; i++) {
        named += (size_t)pbwio__is_named(output->groups + i);
    }
    if (named > 0 && has & keeps && !(keeps & PBWIO_NAMES)) {
        pbwio__append(text, size, "names of groups");
    }
    for (i = 0; i < output->column_count && !(keeps & PBWIO_COLUMNS); i++) {
        pbwio__append(text, size, output->columns[i].name != NULL ? output->columns[i].name : "an attribute");
    }
    if (output->heights != NULL && !(keeps & PBWIO_HEIGHTS)) {
        pbwio__append(text, size, "heights");
    }
    if (mesh->weights != NULL && !(keeps & PBWIO_WEIGHTS)) {
        pbwio__append(text, size, "weights");
    }
}

PBWDEF void pbwio_renamed(pbwio_format format, int corners, const pbw_mesh *mesh, const pbwio_output *output,
                          char *text, size_t size)
{
    pbwio_output o = *output;
    pbw_memory memory;
    pbw_index builtin[2];
    char **words;
    size_t i, used = 0, bytes;
    text[0] = 0;
    o.format = format;
    if (o.groups == NULL || (format != PBWIO_INP && format != PBWIO_SU2)) {
        return;
    }
    pbwio__find_builtin(mesh, &o, (size_t)corners, builtin);
    pbw_memory_start(&memory, o.build);
    words = pbwio__make_words(&memory, &o, corners, builtin, &bytes);
    for (i = 0; words != NULL && i < o.group_count && used + 80 < size; i++) {
        const char *name = o.groups[i].name;
        if (name != NULL && strcmp(name, words[i]) != 0
            && pbwio__word_kind(format, corners, o.groups[i].dim) != 0) {
            used += (size_t)snprintf(text + used, size - used, "%s\"%.30s\" is %.30s", used > 0 ? ", " : "", name,
                                     words[i]);
        }
    }
    if (words != NULL) {
        (void)pbw_memory_resize(&memory, words, bytes, 0, 1);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>read         A file or a block of memory into a cloud.
   In: a path or bytes; options.  Out: the cloud, or a status and a message.
   Holds: on failure the cloud is empty and nothing is held.
   ------------------------------------------------------------------------------------------------------ */

/* Endings of files that are no tables and are not read, whatever they look like, and what to save instead. */
static const struct { const char *endings, *instead; } pbwio__refused[] = {
    { "pvtu vti vtm vtp vtr vts xdmf xmf", ": save it as .vtu, .vtk or .ply" },
    { "3dm 3mf amf brep dgn dwg dxf ifc iges igs sat skp sldprt step stp x_b x_t",
      ": export its surface as .stl or .obj" },
    { "3ds blend dae fbx glb gltf usd usda usdc usdz wrl x3d", ": export it as .obj, .ply or .stl" },
    { "bdf cas cdb cgns exo fem foam h5 hdf5 med meshb mphtxt nas nastran nc ugrid unv",
      ": save it as .msh, .vtu, .mesh or .inp" },
    { "gml gpkg gpx kml kmz shp shx svg wkb wkt", ": save it as .geojson" },
    { "e57 las laz mat npy npz pcd", ": save its points as .ply or .xyz" },
    { "ods xls xlsx xml", ": save the table as .csv" },
    { "html jpg pdf png rar tif tiff vdb zip", "" }
};

/* Refuses a file, and says which are read. */
static pbwio_status pbwio__refuse(pbwio_error *error, const char *name, const char *what, const char *instead)
{
    char text[300] = "";
    const char *ending;
    size_t i, length, used = 0;
    for (i = 1; i < PBWIO__FORMATS; i++) {
        const pbwio__format_info *info = pbwio__format_table + i;
        for (ending = info->endings; *ending != 0 && info->read != NULL; ending += length) {
            ending += *ending == ' ';
            length = strcspn(ending, " ");
            used += (size_t)snprintf(text + used, sizeof text - used, " .%.*s", (int)length, ending);
        }
    }
    return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, name, "%s%s; formats that are read:%s", what, instead,
                             text);
}

/* The format that the content looks like: a first word that only one format has, else a table. */
static pbwio_format pbwio__sniff(pbwio__reader r)
{
    pbwio__reader head = r;
    pbwio__field word;
    r.error = head.error = NULL;
    if (r.end - r.at > 10 && memcmp(r.at, "# vtk Data", 10) == 0) {
        return PBWIO_VTK;
    }
    if (r.end - r.at >= 84) {
        head.at += 80;
        if ((double)(r.end - r.at) == 84 + 50 * pbwio__binary(&head, 5, 0)) {
            return PBWIO_STL;
        }
    }
    while (pbwio__row_line(&r) && pbwio__next(&r, &word)) {
        if (pbwio__is(word, "v") || pbwio__is(word, "o") || pbwio__is(word, "g") || pbwio__is(word, "mtllib")) {
            return PBWIO_OBJ;
        }
        if (*word.begin == '[' || *word.begin == '{') {
            return PBWIO_JSON;
        }
        if (*word.begin == '<') {
            return PBWIO_VTU;
        }
        if (*word.begin == '%') {                                    /* a comment of .su2 */
            continue;
        }
        if (*word.begin == '*') {
            return PBWIO_INP;
        }
        if (word.end - word.begin >= 5 && (pbwio__same(word.begin, 5, "NDIME", 5)
                                           || pbwio__same(word.begin, 5, "NZONE", 5))) {
            return PBWIO_SU2;
        }
        if (pbwio__is(word, "$MeshFormat") || pbwio__is(word, "MeshVersionFormatted")) {
            return *word.begin == '$' ? PBWIO_MSH : PBWIO_MESH;
        }
        return pbwio__is(word, "ply") ? PBWIO_PLY : pbwio__is(word, "solid") ? PBWIO_STL
             : word.end - word.begin >= 3 && pbwio__same(word.end - 3, 3, "OFF", 3) ? PBWIO_OFF : PBWIO_XYZ;
    }
    return PBWIO_XYZ;
}

/* What is wrong with content, whatever its format; NULL: nothing. */
static const char *pbwio__content_error(const char *at, size_t left, pbwio_format format)
{
    if (left == 0) {
        return "the file is empty";
    }
    if (left >= 2 && (memcmp(at, "\xff\xfe", 2) == 0 || memcmp(at, "\xfe\xff", 2) == 0)) {
        return "the file is UTF-16 text: save it as UTF-8";
    }
    if (left >= 4 && (memcmp(at, "PK\3\4", 4) == 0 || memcmp(at, "BZh", 3) == 0 || memcmp(at, "\xfd" "7zX", 4) == 0
                      || memcmp(at, "\x28\xb5\x2f\xfd", 4) == 0)) {
        return "the file is compressed, and not by gzip: unpack it first";
    }
    if (format != PBWIO_STL && format != PBWIO_JSON && format != PBWIO_VTU && memchr(at, '\n', left) == NULL
        && memchr(at, '\r', left) != NULL) {
        return "lines end with CR alone: convert them to LF or CR LF";
    }
    return NULL;
}

/* Reads content into a cloud that is empty or, for .ele .face .edge, has points and simplices. */
static pbwio_status pbwio__read(const char *name, const void *data, size_t size, const pbwio_options *options,
                                pbwio_cloud *cloud, pbwio_error *error)
{
    static const pbwio_options defaults = { PBWIO_AUTO, 0, NULL, NULL, NULL, 0, NULL };
    const char *wrong;
    pbwio_format format;
    pbwio__reader r;
    size_t left, i;
    memset(&r, 0, sizeof r);
    r.name = name;
    r.mark = '.';
    r.begin = r.at = r.line = r.line_end = r.cursor = size == 0 ? "" : (const char *)data;
    r.end = r.begin + size;
    r.options = options == NULL ? &defaults : options;
    r.cloud = cloud;
    r.error = error;
    r.held = cloud->memory.used;
    r.budget = (size > (size_t)-1 / 16 ? (size_t)-1 / 2 : 8 * size) + 65536 + r.held;
    r.group[0] = r.group[1] = r.group[2] = r.group[3] = PBW_NONE;
    if (r.options->dim != 0 && r.options->dim != 2 && r.options->dim != 3) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, name, "dimension %d is not 2 or 3", r.options->dim);
    }
    if (size >= 3 && memcmp(r.at, "\xef\xbb\xbf", 3) == 0) {
        r.at += 3;                                                   /* UTF-8 byte order mark */
    }
    r.report_at = r.at;
    format = r.options->format != PBWIO_AUTO ? r.options->format : pbwio_format_of(name);
    for (i = 0; format == PBWIO_AUTO && i < sizeof pbwio__refused / sizeof *pbwio__refused; i++) {
        if (pbwio__lists(pbwio__refused[i].endings, pbwio__ending(name))) {
            return pbwio__refuse(error, name, "files with this ending are not read", pbwio__refused[i].instead);
        }
    }
    format = format != PBWIO_AUTO ? format : pbwio__sniff(r);
    left = (size_t)(r.end - r.at);
    wrong = pbwio__content_error(r.at, left, format);
    if (wrong != NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_FORMAT, name, "%s", wrong);
    }
    if ((format == PBWIO_XYZ || format == PBWIO_CSV) && memchr(r.at, 0, left < 4096 ? left : 4096) != NULL) {
        return pbwio__refuse(error, name, "the content is binary and no table", "");
    }
    if (pbwio__info_of(format)->read == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, name, "this format is written, not read");
    }
    pbwio__info_of(format)->read(&r);
    pbwio__release(&r, r.group_table, r.group_table_size, sizeof *r.group_table);
    pbwio__cut_polygons(&r);
    if (r.options->keep != NULL && r.options->keep[0] != 0 && cloud->column_count == 0) {
        pbwio__report_dropped(&r, "columns (those of tables are, on request)");
    }
    PBWIO__RELEASE(&r, r.polygons);
    if (r.unread[0] != 0) {
        pbwio__report_dropped(&r, "data: %s", r.unread);
    }
    if (r.status == PBWIO_OK && r.midpoints.at != NULL) {
        pbwio__remove_midpoints(&r);
    }
    PBWIO__RELEASE(&r, r.midpoints);
    if (r.status == PBWIO_OK && cloud->count == 0) {
        r.status = pbwio__file_error(error, PBWIO_ERROR_FORMAT, name, "the file has no points");
    }
    for (i = 0; cloud->heights != NULL && i < cloud->count && !(fabs(cloud->heights[i]) > 0); i++) {
    }
    if (i == cloud->count) {
        pbwio__no_heights(&r);                                       /* all are 0 */
    }
    pbwio__trim_arrays(cloud, 0);
    return r.status;
}

PBWDEF pbwio_status pbwio_read_memory(const char *name, const void *data, size_t size, const pbwio_options *options,
                                      pbwio_cloud *cloud, pbwio_error *error)
{
    const pbw_options *build = options != NULL ? options->build : NULL;
    pbwio__bytes packed = { NULL, 0, 0 }, unpacked = { NULL, 0, 0 };
    pbwio_status status = PBWIO_OK;
    if (cloud == NULL || name == NULL || (data == NULL && size != 0)) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, "pbwio_read_memory", "an argument is NULL");
    }
    memset(cloud, 0, sizeof *cloud);
    pbw_memory_start(&cloud->memory, build);
    if (size >= 2 && memcmp(data, "\x1f\x8b", 2) == 0) {
        packed.at = (char *)(uintptr_t)data;
        packed.count = size;
        status = pbwio__gunzip(name, &packed, &cloud->memory, build, &unpacked, error);
        data = unpacked.at;
        size = unpacked.count;
    }
    status = status != PBWIO_OK ? status : pbwio__read(name, data, size, options, cloud, error);
    PBW_RELEASE(&cloud->memory, unpacked);
    if (status != PBWIO_OK) {
        pbwio_free(cloud);
    }
    return status;
}

/* The whole of a file, unpacked; "-" is the standard input. */
static pbwio_status pbwio__load(const char *path, pbw_memory *memory, const pbw_options *build, pbwio__bytes *data,
                                pbwio_error *error)
{
    const size_t chunk = (size_t)1 << 24;
    const int standard = strcmp(path, "-") == 0;
    FILE *file = standard ? stdin : fopen(path, "rb");
    pbwio_status status = PBWIO_OK;
    size_t got = 1;
    memset(data, 0, sizeof *data);
    if (file == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_FILE, path, "%s", strerror(errno));
    }
    while (got != 0 && status == PBWIO_OK) {
        const size_t room = data->capacity - data->count;
        if (room == 0 && !PBW_RESERVE(memory, *data, data->capacity == 0 ? 65536 : data->capacity)) {
            status = pbwio__file_error(error, PBWIO_ERROR_MEMORY, path, "out of memory");
        } else if (room > 0) {
            got = fread(data->at + data->count, 1, room < chunk ? room : chunk, file);
            data->count += got;
            if (pbwio__stops(build, 0)) {
                status = pbwio__file_error(error, PBWIO_CANCELLED, path, "cancelled");
            }
        }
    }
    if (status == PBWIO_OK && ferror(file)) {
        status = pbwio__file_error(error, PBWIO_ERROR_FILE, path, "%s", strerror(errno));
    }
    if (!standard) {
        fclose(file);
    }
    if (status == PBWIO_OK && data->count >= 2 && memcmp(data->at, "\x1f\x8b", 2) == 0) {
        pbwio__bytes packed = *data;
        memset(data, 0, sizeof *data);
        status = pbwio__gunzip(path, &packed, memory, build, data, error);
        PBW_RELEASE(memory, packed);
    }
    if (status != PBWIO_OK) {
        PBW_RELEASE(memory, *data);
    }
    return status;
}

PBWDEF char *pbwio_load(const char *path, const pbw_options *options, size_t *size, pbwio_error *error)
{
    pbw_memory memory;
    pbwio__bytes data;
    pbw_memory_start(&memory, options);
    if (pbwio__load(path, &memory, options, &data, error) != PBWIO_OK) {
        return NULL;
    }
    if (!PBW_FIT(&memory, data, data.count + 1)) {
        (void)pbwio__file_error(error, PBWIO_ERROR_MEMORY, path, "out of memory");
        PBW_RELEASE(&memory, data);
        return NULL;
    }
    data.at[data.count] = 0;
    *size = data.count;
    return data.at;
}

/* Reads a file into a cloud that is empty or, for .ele .face .edge, has points and simplices. */
static pbwio_status pbwio__read_file(const char *path, const pbwio_options *options, pbwio_cloud *cloud,
                                     pbwio_error *error)
{
    pbwio__bytes data;
    pbwio_status status = pbwio__load(path, &cloud->memory, options != NULL ? options->build : NULL, &data, error);
    if (status == PBWIO_OK) {
        (void)PBW_FIT(&cloud->memory, data, data.count > 0 ? data.count : 1);
        status = pbwio__read(strcmp(path, "-") == 0 ? "standard input" : path, data.at, data.count, options, cloud,
                             error);
        PBW_RELEASE(&cloud->memory, data);
    }
    return status;
}

/* Reads a file of the same name but its ending; optional: if it is there. */
static pbwio_status pbwio__read_beside(const char *path, const char *ending, int optional,
                                       const pbwio_options *options, pbwio_cloud *cloud, pbwio_error *error)
{
    const pbwio__field own = pbwio__ending(path);
    const size_t length = own.end > own.begin ? (size_t)(own.begin - path) : strlen(path);
    char *name = (char *)pbw_memory_resize(&cloud->memory, NULL, 0, length + 8, 1);
    pbwio_options o;
    pbwio_status status = PBWIO_OK;
    FILE *file = NULL;
    memset(&o, 0, sizeof o);
    o = options != NULL ? *options : o;
    o.format = strcmp(ending, "node") == 0 ? PBWIO_NODE : PBWIO_FACE;
    if (name == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_MEMORY, path, "out of memory");
    }
    snprintf(name, length + 8, "%.*s%s%s", (int)length, path, own.end > own.begin ? "" : ".", ending);
    file = optional ? fopen(name, "rb") : NULL;
    if (file != NULL) {
        fclose(file);
    }
    if (file != NULL || !optional) {
        status = pbwio__read_file(name, &o, cloud, error);
    }
    (void)pbw_memory_resize(&cloud->memory, name, length + 8, 0, 1);
    return status;
}

/* Whether a .poly or .smesh file is there and has no points of its own. */
static int pbwio__points_are_beside(const char *path, const pbwio_options *options, pbwio_cloud *cloud)
{
    pbwio__bytes data;
    pbwio__reader r;
    int beside = 0;
    if (pbwio__load(path, &cloud->memory, options != NULL ? options->build : NULL, &data, NULL) == PBWIO_OK) {
        memset(&r, 0, sizeof r);
        r.at = data.count > 0 ? data.at : "";
        r.end = r.at + data.count;
        beside = pbwio__lacks_points(&r);
        PBW_RELEASE(&cloud->memory, data);
    }
    return beside;
}

PBWDEF pbwio_status pbwio_read(const char *path, const pbwio_options *options, pbwio_cloud *cloud, pbwio_error *error)
{
    pbwio_status status = PBWIO_OK;
    pbwio_format format;
    if (path == NULL || cloud == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, "pbwio_read", "an argument is NULL");
    }
    memset(cloud, 0, sizeof *cloud);
    pbw_memory_start(&cloud->memory, options != NULL ? options->build : NULL);
    format = options != NULL && options->format != PBWIO_AUTO ? options->format : pbwio_format_of(path);
    if (format == PBWIO_ELE || format == PBWIO_FACE
        || (format == PBWIO_POLY && strcmp(path, "-") != 0 && pbwio__points_are_beside(path, options, cloud))) {
        status = pbwio__read_beside(path, "node", 0, options, cloud, error);
    }
    status = status != PBWIO_OK ? status : pbwio__read_file(path, options, cloud, error);
    if (format == PBWIO_ELE && status == PBWIO_OK && cloud->dim == 3) {
        status = pbwio__read_beside(path, "face", 1, options, cloud, error);
    }
    if (format == PBWIO_ELE && status == PBWIO_OK) {
        status = pbwio__read_beside(path, "edge", 1, options, cloud, error);
    }
    if (status != PBWIO_OK) {
        pbwio_free(cloud);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>deflate      gzip (RFC 1952) of Deflate (RFC 1951) blocks with codes of their own.
   In: a stream.  Out: a stream; its failures stay in it.
   Holds: memory does not grow with the input.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWIO__WINDOW = 32768, PBWIO__BLOCK = 65536, PBWIO__HASHES = 32768, PBWIO__SHORTEST = 4,
       PBWIO__LONGEST = 258 };

typedef struct pbwio__deflater {
    unsigned char bytes[PBWIO__WINDOW + PBWIO__BLOCK];     /* what matches reach back to, then the block at hand */
    int32_t head[PBWIO__HASHES];             /* the last position with a hash; -1: none */
    int32_t before[PBWIO__WINDOW];           /* of a position: the last one before it with the same hash */
    uint32_t tokens[PBWIO__BLOCK];           /* 65536 times a literal or a length, plus the distance; 0: a literal */
    size_t token_count;
    uint32_t count[286 + 30];                /* of each symbol: literals and lengths, then distances */
    unsigned char length[286 + 30];
    uint16_t code[286 + 30];                 /* the first bit lowest */
    uint64_t bits;
    int bit_count;
    FILE *out;
    unsigned char packed[8192];
    size_t used;
} pbwio__deflater;

static void pbwio__put_bytes(pbwio__deflater *z, int count)         /* of the first bits, count <= 8 */
{
    if (z->used + 8 > sizeof z->packed) {
        fwrite(z->packed, 1, z->used, z->out);
        z->used = 0;
    }
    for (; count > 0; count--) {
        z->packed[z->used++] = (unsigned char)(z->bits & 255);
        z->bits >>= 8;
        z->bit_count -= 8;
    }
}

static void pbwio__put_bits(pbwio__deflater *z, uint64_t bits, int count)        /* count <= 16 */
{
    z->bits |= bits << z->bit_count;
    z->bit_count += count;
    if (z->bit_count >= 48) {
        pbwio__put_bytes(z, 6);
    }
}

/* Enters the four bytes at a position.  Returns the last position before it with their hash, or -1. */
static int pbwio__hash_position(pbwio__deflater *z, int at)
{
    int32_t *head = z->head + ((pbwio__word(z->bytes + at) * 0x9e3779b1u) >> 17);
    const int position = *head;
    z->before[at % PBWIO__WINDOW] = position;
    *head = at;
    return position;
}

/* The longest match at a position among ten with its hash; 0: there is none. */
static int pbwio__match(pbwio__deflater *z, int at, int end, int *distance)
{
    const unsigned char *s = z->bytes + at;
    const int longest = end - at < PBWIO__LONGEST ? end - at : PBWIO__LONGEST;
    int best = PBWIO__SHORTEST - 1, position, tries, length;
    if (longest < PBWIO__SHORTEST) {
        return 0;
    }
    position = pbwio__hash_position(z, at);
    for (tries = 0; tries < 10 && position >= 0 && at - position <= PBWIO__WINDOW && best < longest; tries++) {
        const unsigned char *t = z->bytes + position;
        if (t[best] == s[best] && memcmp(t, s, PBWIO__SHORTEST) == 0) {
            for (length = PBWIO__SHORTEST; length < longest && t[length] == s[length]; length++) {
            }
            if (length > best) {
                best = length;
                *distance = at - position;
            }
        }
        length = position;
        position = z->before[position % PBWIO__WINDOW];
        if (position >= length) {                                       /* that position was overwritten */
            break;
        }
    }
    return best < PBWIO__SHORTEST ? 0 : best;
}

/* The symbol of a length less 3 (kind 4) or of a distance less 1 (kind 2); the number of extra bits. */
static int pbwio__symbol_of(int value, int kind, int *extra)
{
    for (*extra = 0; value >> *extra >= 2 * kind; ++*extra) {
    }
    return kind * *extra + (value >> *extra);
}

static int pbwio__length_symbol(int length, int *extra)
{
    const int symbol = 257 + pbwio__symbol_of(length - 3, 4, extra);
    if (length == PBWIO__LONGEST) {                                  /* has a symbol of its own */
        *extra = 0;
        return 285;
    }
    return symbol;
}

static void pbwio__add_token(pbwio__deflater *z, int length, int distance)
{
    int extra;
    z->tokens[z->token_count++] = (uint32_t)length << 16 | (uint32_t)distance;
    if (distance == 0) {
        z->count[length]++;
    } else {
        z->count[pbwio__length_symbol(length, &extra)]++;
        z->count[286 + pbwio__symbol_of(distance - 1, 2, &extra)]++;
    }
}

/* Parts a block into literals and matches; a match waits for one that starts a byte later and is longer. */
static void pbwio__tokenize(pbwio__deflater *z, int end)
{
    int at = PBWIO__WINDOW, distance = 0, later = 0, length = pbwio__match(z, at, end, &distance), next, k;
    while (at < end) {
        next = at + 1 < end && length < 32 ? pbwio__match(z, at + 1, end, &later) : 0;
        if (length == 0 || next > length) {
            pbwio__add_token(z, z->bytes[at++], 0);
            length = next;
            distance = later;
        } else {
            pbwio__add_token(z, length, distance);
            for (k = at + (length < 32 ? 2 : 1); k < at + length && k <= end - PBWIO__SHORTEST; k++) {
                pbwio__hash_position(z, k);
            }
            at += length;
            length = at < end ? pbwio__match(z, at, end, &distance) : 0;
        }
    }
}

/* Lengths of a Huffman code for n symbols that are not over `most`, and the code. */
static void pbwio__make_code(const uint32_t *count, int n, int most, unsigned char *length, uint16_t *code)
{
    uint32_t weight[2 * 286];
    int symbol[286], parent[2 * 286], of_length[16], used = 0, i, k, leaf, node, fill;
    unsigned next = 0, kraft = 0;
    memset(length, 0, (size_t)n);
    memset(of_length, 0, sizeof of_length);
    for (i = 0; i < n; i++) {
        if (count[i] > 0) {                                          /* rarest first */
            for (k = used++; k > 0 && count[symbol[k - 1]] > count[i]; k--) {
                symbol[k] = symbol[k - 1];
            }
            symbol[k] = i;
        }
    }
    for (i = 0; i < used; i++) {
        weight[i] = count[symbol[i]];
    }
    for (leaf = 0, node = fill = used; fill < 2 * used - 1; fill++) {
        for (k = 0, weight[fill] = 0; k < 2; k++) {                  /* the lightest leaf or node without a parent */
            i = leaf < used && (node == fill || weight[leaf] <= weight[node]) ? leaf++ : node++;
            weight[fill] += weight[i];
            parent[i] = fill;
        }
    }
    for (i = 2 * used - 2; i >= 0; i--) {                            /* depths take the position of parents */
        parent[i] = i == 2 * used - 2 ? (used == 1) : parent[parent[i]] + 1;
        if (i < used) {
            k = parent[i] < most ? parent[i] : most;
            of_length[k]++;
            kraft += 1u << (most - k);
        }
    }
    for (; kraft > 1u << most; kraft--) {                            /* a code that is too short: splits a leaf */
        for (k = most - 1; of_length[k] == 0; k--) {
        }
        of_length[most]--;
        of_length[k]--;
        of_length[k + 1] += 2;
    }
    for (i = 0, k = most; i < used; i++) {
        for (; of_length[k] == 0; k--) {
        }
        length[symbol[i]] = (unsigned char)k;
        of_length[k]--;
    }
    for (k = 1; k <= most; k++, next <<= 1) {
        for (i = 0; i < n; i++) {
            if (length[i] == k) {
                for (code[i] = 0, fill = 0; fill < k; fill++) {
                    code[i] = (uint16_t)(code[i] | (next >> fill & 1) << (k - 1 - fill));
                }
                next++;
            }
        }
    }
}

/* Writes the lengths of both codes: runs of 16 a length again, 17 and 18 zeros. */
static void pbwio__put_lengths(pbwio__deflater *z)
{
    static const unsigned char order[19] = { 16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15 };
    unsigned char run[286 + 30], extra[286 + 30], length[19];
    uint32_t count[19];
    uint16_t code[19];
    int runs = 0, i, k, n;
    memset(count, 0, sizeof count);
    for (i = 0; i < 286 + 30; i += k) {
        for (k = 1; i + k < 286 + 30 && z->length[i + k] == z->length[i]; k++) {
        }
        if (z->length[i] == 0 && k >= 3) {
            k = k < 138 ? k : 138;
            run[runs] = k < 11 ? 17 : 18;
            extra[runs] = (unsigned char)(k - (k < 11 ? 3 : 11));
        } else if (z->length[i] != 0 && i > 0 && z->length[i - 1] == z->length[i] && k >= 3) {
            k = k < 6 ? k : 6;
            run[runs] = 16;
            extra[runs] = (unsigned char)(k - 3);
        } else {
            k = 1;
            run[runs] = z->length[i];
        }
        count[run[runs++]]++;
    }
    pbwio__make_code(count, 19, 7, length, code);
    for (n = 19; n > 4 && length[order[n - 1]] == 0; n--) {
    }
    pbwio__put_bits(z, 286 - 257, 5);
    pbwio__put_bits(z, 30 - 1, 5);
    pbwio__put_bits(z, (uint64_t)n - 4, 4);
    for (i = 0; i < n; i++) {
        pbwio__put_bits(z, length[order[i]], 3);
    }
    for (i = 0; i < runs; i++) {
        pbwio__put_bits(z, code[run[i]], length[run[i]]);
        pbwio__put_bits(z, run[i] < 16 ? 0 : extra[i], run[i] < 16 ? 0 : run[i] == 16 ? 2 : run[i] == 17 ? 3 : 7);
    }
}

/* Writes the tokens as a block. */
static void pbwio__put_block(pbwio__deflater *z, int last)
{
    int symbol, extra, length, distance;
    size_t i;
    z->count[256] = 1;                                               /* the end of the block */
    z->count[286] += 1;                                              /* there is a distance at least */
    pbwio__make_code(z->count, 286, 15, z->length, z->code);
    pbwio__make_code(z->count + 286, 30, 15, z->length + 286, z->code + 286);
    pbwio__put_bits(z, (uint64_t)(4 + last), 3);
    pbwio__put_lengths(z);
    for (i = 0; i < z->token_count; i++) {
        length = (int)(z->tokens[i] >> 16);
        distance = (int)(z->tokens[i] & 65535);
        if (distance == 0) {
            pbwio__put_bits(z, z->code[length], z->length[length]);
            continue;
        }
        symbol = pbwio__length_symbol(length, &extra);
        pbwio__put_bits(z, z->code[symbol], z->length[symbol]);
        pbwio__put_bits(z, (uint64_t)(length - 3) & (((uint64_t)1 << extra) - 1), extra);
        symbol = 286 + pbwio__symbol_of(distance - 1, 2, &extra);
        pbwio__put_bits(z, z->code[symbol], z->length[symbol]);
        pbwio__put_bits(z, (uint64_t)(distance - 1) & (((uint64_t)1 << extra) - 1), extra);
    }
    pbwio__put_bits(z, z->code[256], z->length[256]);
    memset(z->count, 0, sizeof z->count);
    z->token_count = 0;
}

/* Packs the rest of a stream into another one.  PBWIO_ERROR_FILE: the streams failed. */
static pbwio_status pbwio__gzip(FILE *in, FILE *out, pbw_memory *memory, const pbw_options *build)
{
    static const unsigned char header[10] = { 0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255 };
    pbwio__deflater *z = (pbwio__deflater *)pbw_memory_resize(memory, NULL, 0, 1, sizeof *z);
    uint32_t crc = 0, size = 0;
    size_t got, i;
    int stopped = 0;
    if (z == NULL) {
        return PBWIO_ERROR_MEMORY;
    }
    memset(z, 0, sizeof *z);
    memset(z->head, 0xff, sizeof z->head);                           /* -1 */
    z->out = out;
    fwrite(header, 1, sizeof header, out);
    do {
        got = fread(z->bytes + PBWIO__WINDOW, 1, PBWIO__BLOCK, in);
        crc = pbwio__crc(crc, z->bytes + PBWIO__WINDOW, got);
        size += (uint32_t)got;
        pbwio__tokenize(z, PBWIO__WINDOW + (int)got);
        pbwio__put_block(z, got < PBWIO__BLOCK);
        memmove(z->bytes, z->bytes + PBWIO__BLOCK, PBWIO__WINDOW);
        for (i = 0; i < PBWIO__HASHES; i++) {
            z->head[i] = z->head[i] >= PBWIO__BLOCK ? z->head[i] - PBWIO__BLOCK : -1;
            z->before[i] = z->before[i] >= PBWIO__BLOCK ? z->before[i] - PBWIO__BLOCK : -1;
        }
        stopped = pbwio__stops(build, 1);
    } while (got == PBWIO__BLOCK && !stopped);
    pbwio__put_bytes(z, (z->bit_count + 7) / 8);
    z->bits = (uint64_t)size << 32 | crc;
    pbwio__put_bytes(z, 8);
    fwrite(z->packed, 1, z->used, out);
    (void)pbw_memory_resize(memory, z, 1, 0, sizeof *z);
    return stopped ? PBWIO_CANCELLED : ferror(in) ? PBWIO_ERROR_FILE : PBWIO_OK;
}

/* ------------------------------------------------------------------------------------------------------
   >>write        A mesh into a file that is whole or is not there.
   In: a path, a mesh; or a function that writes to a stream.  Out: the file, or a status and a message.
   Holds: on failure the old file is as it was and no part of a new one is left.
   ------------------------------------------------------------------------------------------------------ */

typedef struct pbwio__job {                  /* what is to be written */
    void (*emit)(void *user, FILE *file);
    void *user;
    const int *cancelled;                    /* whether emit was stopped; NULL: ask progress */
    const pbw_options *build;
} pbwio__job;

#ifdef _WIN32
static int pbwio__target(const char *path, pbw_memory *memory, pbwio__bytes *name)
{
    const int done = PBW_FIT(memory, *name, strlen(path) + 1);
    if (done) {
        strcpy(name->at, path);
    }
    return done;
}

static FILE *pbwio__exclusive(const char *name)      /* fopen of some C libraries there has no "x" */
{
    const int file = _open(name, _O_CREAT | _O_EXCL | _O_RDWR | _O_BINARY, _S_IREAD | _S_IWRITE);
    return file >= 0 ? _fdopen(file, "wb") : NULL;
}
#else
static FILE *pbwio__exclusive(const char *name)      /* a file that is there, or a link, is not touched */
{
    return fopen(name, "wbx");
}

/* The name that symbolic links at the end of a path lead to.  After 40 links it is left as it is.  Returns 0 = out of
   memory. */
static int pbwio__target(const char *path, pbw_memory *memory, pbwio__bytes *name)
{
    enum { MOST = 4096 };
    char link[MOST];
    int links;
    ssize_t length;
    if (!PBW_FIT(memory, *name, strlen(path) + 1)) {
        return 0;
    }
    strcpy(name->at, path);
    for (links = 0; links < 40 && (length = readlink(name->at, link, MOST - 1)) > 0; links++) {
        const char *slash = strrchr(name->at, '/');
        size_t folder = *link == '/' || slash == NULL ? 0 : (size_t)(slash - name->at) + 1;
        if (!PBW_FIT(memory, *name, folder + (size_t)length + 1)) {
            return 0;
        }
        memcpy(name->at + folder, link, (size_t)length);
        name->at[folder + (size_t)length] = 0;
    }
    return 1;
}
#endif

/* Creates a file beside the target under a name of its own.  Returns NULL if that fails; the name has no bytes then
   if there was no memory. */
static FILE *pbwio__create(const char *target, pbw_memory *memory, pbwio__bytes *name)
{
    enum { MOST = 200, MORE = 48 };          /* bytes of the last name, which systems limit to 255; after it */
    size_t length, last = 0;
    unsigned number;
    FILE *file = NULL;
    for (length = 0; target[length] != 0; length++) {
        last = target[length] == '/' || target[length] == '\\' ? length + 1 : last;
    }
    if (length - last > MOST) {
        for (length = last + MOST; ((unsigned char)target[length] & 0xc0) == 0x80; length--) {       /* whole UTF-8 */
        }
    }
    if (!PBW_FIT(memory, *name, length + MORE)) {
        return NULL;
    }
    for (number = 0; file == NULL && (number == 0 || (errno == EEXIST && number < 10000)); number++) {
        snprintf(name->at, length + MORE, "%.*s.part.%lu-%u", (int)length, target, (unsigned long)PBWIO__PROCESS(),
                 number);
        file = pbwio__exclusive(name->at);
    }
    return file;
}

/* Writes to a stream, packed by gzip or as it is, and closes it, unless it is the standard output. */
static pbwio_status pbwio__stream(FILE *file, pbw_memory *memory, int packed, const pbwio__job *job)
{
    FILE *plain = packed ? tmpfile() : file;
    pbwio_status status = PBWIO_ERROR_FILE;
    if (plain != NULL) {
        job->emit(job->user, plain);
        status = ferror(plain) | fflush(plain) ? PBWIO_ERROR_FILE
               : (job->cancelled != NULL ? *job->cancelled : pbwio__stops(job->build, 1)) ? PBWIO_CANCELLED
               : PBWIO_OK;
    }
    if (packed && status == PBWIO_OK) {
        rewind(plain);
        status = pbwio__gzip(plain, file, memory, job->build);
    }
    if (packed && plain != NULL) {
        fclose(plain);
    }
    if ((ferror(file) | fflush(file)) && status == PBWIO_OK) {
        status = PBWIO_ERROR_FILE;
    }
    return file != stdout && fclose(file) != 0 && status == PBWIO_OK ? PBWIO_ERROR_FILE : status;
}

static pbwio_status pbwio__save(const char *path, const pbwio__job *job, pbwio_error *error)
{
    struct stat old;
    pbw_memory memory;
    pbwio__bytes target = { NULL, 0, 0 }, name = { NULL, 0, 0 };
    FILE *file = NULL;
    const int is = stat(path, &old) == 0;
    const int in_place = strcmp(path, "-") == 0 || strncmp(path, "/dev/", 5) == 0 || (is && !S_ISREG(old.st_mode));
    pbwio_status status;
    pbw_memory_start(&memory, job->build);
    status = pbwio__target(path, &memory, &target) ? PBWIO_OK : PBWIO_ERROR_MEMORY;
    errno = 0;
    if (in_place && status == PBWIO_OK) {
        file = strcmp(path, "-") == 0 ? stdout : fopen(path, "wb");
        status = file != NULL ? PBWIO_OK : PBWIO_ERROR_FILE;
    } else if (is && status == PBWIO_OK) {           /* a file that may not be written to may not be replaced */
        file = fopen(target.at, "r+b");
        status = file == NULL || fclose(file) != 0 ? PBWIO_ERROR_FILE : PBWIO_OK;
    }
    if (!in_place && status == PBWIO_OK) {
        file = pbwio__create(target.at, &memory, &name);
        status = name.at == NULL ? PBWIO_ERROR_MEMORY : file == NULL ? PBWIO_ERROR_FILE : PBWIO_OK;
    }
    if (status == PBWIO_OK) {
        status = pbwio__stream(file, &memory, pbwio__is_gz(path), job);
        if (name.at != NULL && status == PBWIO_OK) {
            if (is) {
                chmod(name.at, old.st_mode & 07777);
            }
#ifdef _WIN32
            remove(target.at);                       /* rename does not replace there */
#endif
            status = rename(name.at, target.at) != 0 ? PBWIO_ERROR_FILE : PBWIO_OK;
        }
        if (name.at != NULL && status != PBWIO_OK) {
            const int reason = errno;
            remove(name.at);
            errno = reason;
        }
    }
    if (status != PBWIO_OK) {
        (void)pbwio__file_error(error, status, strcmp(path, "-") == 0 ? "standard output" : path, "%s",
                                status == PBWIO_ERROR_MEMORY ? "out of memory"
                                : status == PBWIO_CANCELLED ? "cancelled"
                                : errno == 0 ? "cannot write" : strerror(errno));
    }
    PBW_RELEASE(&memory, name);
    PBW_RELEASE(&memory, target);
    return status;
}

PBWDEF pbwio_status pbwio_save(const char *path, void (*emit)(void *user, FILE *file), void *user,
                               const pbw_options *options, pbwio_error *error)
{
    pbwio__job job;
    if (path == NULL || emit == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, "pbwio_save", "an argument is NULL");
    }
    job.emit = emit;
    job.user = user;
    job.cancelled = NULL;
    job.build = options;
    return pbwio__save(path, &job, error);
}

static void pbwio__emit(void *user, FILE *file)
{
    pbwio__writer *w = (pbwio__writer *)user;
    const pbwio__format_info *info = pbwio__info_of(w->output->format);
    w->file = file;
    w->text = !w->binary;
    if (w->output->format == PBWIO_MSH && w->items != NULL) {
        pbwio__write_msh(w);
    } else if (w->output->format == PBWIO_MSH2 && w->items != NULL) {
        pbwio__write_msh2(w);
    } else if (info->write != NULL) {
        info->write(w);
    } else {
        pbwio__print_form(w, info->form);
        if (w->output->format == PBWIO_INP && w->items != NULL) {
            pbwio__write_inp(w);
        }
    }
    pbwio__flush(w);
}

/* Sets up the writer from the info of file, the mesh and the caller's output; counts the simplices to write. */
static void pbwio__writer_start(pbwio__writer *w, const pbwio__format_info *info, const pbw_mesh *mesh,
                                size_t corners, const pbwio_output *output)
{
    size_t i;
    memset(w, 0, sizeof *w);
    w->mesh = mesh;
    w->output = output;
    w->separator = info->traits & PBWIO__COMMAS ? ',' : ' ';
    w->longest = output->format == PBWIO_INP ? 20 : 40;
    w->id_size = output->format == PBWIO_MSH ? 8 : 4;
    w->real_size = output->format == PBWIO_STL ? 4 : 8;
    w->base = info->traits & PBWIO__FROM_1 ? 1 : info->traits & PBWIO__BASE ? (unsigned)output->base : 0;
    w->dim = (size_t)mesh->dim;
    w->corners = corners;
    w->binary = info->traits & PBWIO__BINARY && !(output->flags & PBWIO_TEXT)
             && (output->format != PBWIO_STL || pbwio__little_endian());     /* STL has no other byte order */
    w->point_count = mesh->point_count;
    for (i = 0; output->groups != NULL && i < output->group_count; i++) {
        const long long tag = output->groups[i].tag;
        w->largest = tag > w->largest && tag <= PBWIO__MOST_TAG ? tag : w->largest;
    }
    pbwio__rewind(w);
    while (pbwio__step(w, 0)) {
        w->cell_count++;
        for (i = 0; i < corners; i++) {
            w->facet_count += (size_t)pbwio__on_hull(w, w->simplex, i);
        }
    }
    w->all_rows = (w->point_count + w->cell_count + w->facet_count) * (output->format == PBWIO_VTU ? 4 : 1);
}

static void pbwio__writer_end(pbwio__writer *w)
{
    pbw_memory memory = w->memory;
    if (w->boundary != NULL) {
        (void)pbw_memory_resize(&memory, w->boundary, w->mesh->point_count + 1, 0, 1);
    }
    if (w->words != NULL) {
        (void)pbw_memory_resize(&memory, w->words, w->words_size, 0, 1);
    }
    (void)pbw_memory_fit(&memory, &w->number, &w->number_size, 0, 1);
    (void)pbw_memory_fit(&memory, &w->items, &w->item_capacity, 0, sizeof *w->items);
    (void)pbw_memory_resize(&memory, w, 1, 0, sizeof *w);
}

/* Writes a mesh; or a model, whose simplices are triangles in any dimension and which has all of its points. */
static pbwio_status pbwio__write(const char *path, const pbw_mesh *mesh, int model, const double *normals,
                                 const pbwio_output *output, pbwio_error *error)
{
    pbwio_output settings;
    const pbwio__format_info *info;
    pbw_memory memory;
    pbw_options build;
    pbwio__job job;
    pbwio_status status;
    pbwio__writer *w;
    size_t corners = model ? 3 : (size_t)mesh->dim + 1;
    int surface, grouped, failed = 0;
    memset(&settings, 0, sizeof settings);
    settings = output != NULL ? *output : settings;
    settings.format = settings.format != PBWIO_AUTO ? settings.format : pbwio_format_of(path);
    info = pbwio__info_of(settings.format);
    surface = (info->traits & PBWIO__SURFACE) != 0;
    if (info->write == NULL && info->form == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, path, "no format of that name is written");
    }
    if (mesh->neighbors == NULL && mesh->simplex_count > 0
        && (info->traits & PBWIO__SIMPLICES || (surface && corners == 4))) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, path, "this format needs neighbors, the mesh has none");
    }
    pbw_memory_start(&memory, settings.build);
    w = (pbwio__writer *)pbw_memory_resize(&memory, NULL, 0, 1, sizeof *w);
    if (w == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_MEMORY, path, "out of memory");
    }
    pbwio__writer_start(w, info, mesh, corners, &settings);
    w->memory = memory;
    w->normals = normals;
    if (info->traits & PBWIO__BOUNDARY) {
        failed = (w->boundary = pbwio__used_points(w, 1)) == NULL;
    }
    if (info->traits & PBWIO__SIMPLICES) {
        failed = !pbw_memory_fit(&w->memory, &w->number, &w->number_size,
                                 (mesh->simplex_count + 1) * sizeof *w->number, 1);
        pbwio__rewind(w);
        while (!failed && pbwio__step(w, 0)) {
            w->number[w->simplex] = (pbw_index)w->cell;
        }
    } else if ((!model || settings.format == PBWIO_INP)
               && (surface || info->traits & PBWIO__NO_ORPHANS || settings.flags & PBWIO_NO_ORPHANS)) {
        failed |= !pbwio__number_points(w, surface && corners == 4);
    }
    grouped = settings.patches != NULL || settings.edges != NULL || settings.point_groups != NULL
           || (settings.format != PBWIO_VTU && (settings.regions != NULL || settings.groups != NULL));
    grouped |= model && settings.format != PBWIO_VTU && !surface;
    grouped &= !surface || (settings.groups != NULL && (corners == 4 ? settings.patches : settings.regions) != NULL);
    if (!failed && grouped && info->traits & PBWIO__GROUPED) {
        failed = !pbwio__list_items(w, (info->traits & PBWIO__HULL) != 0);
    }
    if (!failed && settings.groups != NULL && (settings.format == PBWIO_INP || settings.format == PBWIO_SU2)) {
        pbwio__find_builtin(mesh, &settings, corners, w->builtin);
        w->words = pbwio__make_words(&w->memory, &settings, (int)corners, w->builtin, &w->words_size);
        failed = w->words == NULL;
    }
    memset(&build, 0, sizeof build);
    build = settings.build != NULL ? *settings.build : build;
    pbw_memory_nest(&w->memory, &build);
    job.emit = pbwio__emit;
    job.user = w;
    job.cancelled = &w->cancelled;
    job.build = &build;
    status = failed ? pbwio__file_error(error, PBWIO_ERROR_MEMORY, path, "out of memory")
                    : pbwio__save(path, &job, error);
    pbwio__writer_end(w);
    return status;
}

PBWDEF pbwio_status pbwio_write(const char *path, const pbw_mesh *mesh, const pbwio_output *output,
                                pbwio_error *error)
{
    if (path == NULL || mesh == NULL || (mesh->dim != 2 && mesh->dim != 3)) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, "pbwio_write", "no path or no mesh");
    }
    return pbwio__write(path, mesh, 0, NULL, output, error);
}

#endif /* PBW_IO_IMPLEMENTATION */
