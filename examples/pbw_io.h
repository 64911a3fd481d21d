/* pbw_io.h - v0.1.0 - reads point clouds and models, writes meshes - MIT-0

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

   READS     what                                     columns that can be chosen
     .obj    v and f lines, polygons, negative ids    numbers of the v line
     .ply    ascii and binary, both byte orders, any  properties by name or number
             properties in any order, lists
     .stl    ascii and binary; each triangle has its  -
             own three corners
     .off    OFF, COFF, NOFF, STOFF                   numbers of the vertex line
     .node   TetGen and Triangle, 0- or 1-based       x y (z), then attributes, then the marker
     .xyz .csv .txt .tsv .pts .asc .dat               by name if there is a header line, or number;
             separated by blanks, commas, semicolons  a line that starts with # is a comment
     Any other name: the content decides.

   WRITES    what                                             text or binary
     .vtu    simplices, quality, point ids (ParaView, VTK)    both, binary unless PBWIO_TEXT
     .msh    simplices and hull, Gmsh 4.1, physical groups    both, binary unless PBWIO_TEXT
     .mesh   simplices and hull, Medit (FreeFem++, Mmg)       text
     .node .ele .neigh    TetGen's three files, 0-based       text
     .ply .stl            3D: the hull; 2D: the triangles     both, binary unless PBWIO_TEXT
     .obj                 the same                            text
     .xyz .csv            points                              text

   PROMISES  (and the test that guards each)
     exact       numbers are read correctly rounded and written so that they read back the same, in every
                 locale                                                                     tests/test_io.c
     says where  a bad file is refused with "name:line: what" or "name: byte N: what"       tests/test_io.c
     bounded     a file of n bytes makes the readers hold at most 8 n bytes + 64 KiB beside its own text;
                 nothing recurses; the stack needed is below 64 KiB                         tests/test_io.c
     safe        no input, however broken, crashes or hangs a reader                        tests/fuzz_io.c
     whole       a file is written under another name and renamed at the end: there is the whole file or
                 none                                                                       tests/test_io.c
     quiet       no globals, nothing printed, no locale set, no exit

   CONVENTIONS
     Positive simplices, as in pbw.h.  Quality is the mean ratio: 1 for the regular simplex, 0 for a flat one.
      Facets of the hull turn counter-clockwise seen from outside.
     Points keep their ids, so a file can hold points that are corners of nothing: duplicates and hidden points.
     PBWIO_NO_ORPHANS leaves those out and numbers the rest anew (solvers want that).  .obj .stl .ply of a hull
     hold the corners of the hull only.

   CONFIGURATION MACROS
     PBW_IO_IMPLEMENTATION    in one source file: compile the implementation there
     PBWIODEF                 everywhere: your own linkage for the functions, for example static
     PBWIO_REALLOC(ptr, n)    where PBW_IO_IMPLEMENTATION is: your own realloc
     PBWIO_FREE(ptr)          where PBW_IO_IMPLEMENTATION is: your own free
*/
#ifndef PBW_IO_H
#define PBW_IO_H
#ifndef PBW_H
#include "pbw.h"
#endif
#include <stdio.h>

#ifndef PBWIODEF
#define PBWIODEF extern
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum pbwio_status {
    PBWIO_OK = 0,
    PBWIO_ERROR_FILE,                  /* cannot open, read, write or rename; the disk is full */
    PBWIO_ERROR_FORMAT,                /* the content is not what the format says */
    PBWIO_ERROR_ARGUMENT,              /* unknown format, no such column, mesh without what the format needs */
    PBWIO_ERROR_MEMORY                 /* out of memory, or more than the bound above */
} pbwio_status;

typedef struct pbwio_error {           /* filled when a function fails; may be NULL */
    char text[512];                    /* "name:line: what", no newline */
} pbwio_error;

typedef enum pbwio_format {
    PBWIO_AUTO = 0,                    /* reading: by name, then by content; writing: by name */
    PBWIO_OBJ, PBWIO_PLY, PBWIO_STL, PBWIO_OFF, PBWIO_NODE, PBWIO_XYZ, PBWIO_CSV,     /* XYZ, CSV: any table */
    PBWIO_VTU, PBWIO_MSH, PBWIO_MESH, PBWIO_ELE, PBWIO_NEIGH                          /* written only */
} pbwio_format;

typedef struct pbwio_cloud {           /* start from {0}; pbwio_free when done */
    int dim;                           /* 2 or 3 coordinates a point */
    size_t count;
    double *points;                    /* count*dim, all finite */
    double *weights;                   /* count, or NULL if no weight column was asked for */
    size_t triangle_count;             /* faces of a model, polygons cut into fans; 0 for tables and .node */
    pbw_index *triangles;              /* triangle_count*3 ids of points, each < count */
} pbwio_cloud;

typedef struct pbwio_options {         /* NULL or all zero = best defaults */
    pbwio_format format;
    int dim;                           /* 0 = what the file has, 2 = leave z out, 3 = refuse a file without z */
    const char *columns;               /* "2,3,4" or "east,north": x,y or x,y,z, numbered from 1 or named; NULL = the
                                          columns named x y z, else the first that are not the weight */
    const char *weight;                /* the same for the weight; NULL = no weights */
} pbwio_options;

#define PBWIO_TEXT       1u            /* text even where the format has a binary form */
#define PBWIO_NO_ORPHANS 2u            /* leave out points that are corners of nothing written */

typedef struct pbwio_output {          /* NULL or all zero = best defaults */
    pbwio_format format;
    unsigned flags;                    /* PBWIO_TEXT | PBWIO_NO_ORPHANS */
    const unsigned char *keep;         /* one a simplex, 0 = leave it out; the hull is that of the rest; NULL = all */
    const double *values;              /* one number a simplex, an array more in .vtu; NULL = none */
    const char *value_name;            /* its name, NULL = "value" */
} pbwio_output;

/* Reads a file; "-" is the standard input.  cloud: overwritten (what it held is not freed), left empty on failure. */
PBWIODEF pbwio_status pbwio_read(const char *path, const pbwio_options *options, pbwio_cloud *cloud,
                                 pbwio_error *error);
/* Reads a file that is in memory; name is for its format and for messages.  data is not kept. */
PBWIODEF pbwio_status pbwio_read_memory(const char *name, const void *data, size_t size, const pbwio_options *options,
                                        pbwio_cloud *cloud, pbwio_error *error);
/* Frees what a cloud holds and zeroes it; fine on {0}, fine twice. */
PBWIODEF void pbwio_free(pbwio_cloud *cloud);
/* Writes a mesh. */
PBWIODEF pbwio_status pbwio_write(const char *path, const pbw_mesh *mesh, const pbwio_output *output,
                                  pbwio_error *error);
/* Writes any file whole or not at all: emit writes to the stream and need not look for errors; "path.part" is then
   renamed to path, or removed if the disk was full.  Names under /dev are written in place. */
PBWIODEF pbwio_status pbwio_save(const char *path, void (*emit)(void *user, FILE *file), void *user,
                                 pbwio_error *error);
/* The format that a name's ending stands for, PBWIO_AUTO if none. */
PBWIODEF pbwio_format pbwio_format_of(const char *path);

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

#ifndef PBWIO_REALLOC
#define PBWIO_REALLOC(ptr, size) realloc(ptr, size)
#define PBWIO_FREE(ptr) free(ptr)
#endif

#if defined(__GNUC__)
#define PBWIO__PRINTF(a, b) __attribute__((format(printf, a, b)))
#else
#define PBWIO__PRINTF(a, b)
#endif

/* ------------------------------------------------------------------------------------------------------
   Names and messages.
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

PBWIODEF pbwio_format pbwio_format_of(const char *path)
{
    static const struct { const char *ending; pbwio_format format; } known[] = {
        { "obj", PBWIO_OBJ }, { "ply", PBWIO_PLY }, { "stl", PBWIO_STL }, { "off", PBWIO_OFF },
        { "node", PBWIO_NODE }, { "xyz", PBWIO_XYZ }, { "txt", PBWIO_XYZ }, { "pts", PBWIO_XYZ },
        { "asc", PBWIO_XYZ }, { "dat", PBWIO_XYZ }, { "tsv", PBWIO_XYZ }, { "csv", PBWIO_CSV },
        { "vtu", PBWIO_VTU }, { "msh", PBWIO_MSH }, { "mesh", PBWIO_MESH }, { "ele", PBWIO_ELE },
        { "neigh", PBWIO_NEIGH }
    };
    const char *dot = strrchr(path, '.');
    size_t i;
    for (i = 0; dot != NULL && i < sizeof known / sizeof known[0]; i++) {
        if (pbwio__same(dot + 1, strlen(dot + 1), known[i].ending, strlen(known[i].ending))) {
            return known[i].format;
        }
    }
    return PBWIO_AUTO;
}

static void pbwio__message(pbwio_error *error, const char *name, const char *place, const char *format, va_list list)
{
    size_t length = strlen(name), used;
    const char *tail = length > 200 ? name + length - 200 : name;      /* the end of a long path tells more */
    if (error != NULL) {
        snprintf(error->text, sizeof error->text, "%s%s%s ", length > 200 ? "..." : "", tail, place);
        used = strlen(error->text);
        vsnprintf(error->text + used, sizeof error->text - used, format, list);
    }
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
   Numbers.  Decimal text to the nearest double and back, whatever the locale.
   ------------------------------------------------------------------------------------------------------ */

/* The digits of a number that has been found well-formed, as an integer and a power of ten, so that no decimal point
   and no locale is involved.  A double or a midpoint of two has at most 767 significant digits; of more digits than
   that it matters only whether the rest is zero. */
static double pbwio__long_number(const char *s, const char *end, long long exponent)
{
    char digits[840];
    int count = 0, point = 0, rest = 0, negative = *s == '-';
    for (s += *s == '-' || *s == '+'; s < end; s++) {
        if (*s == '.') {
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

/* 1 if [s, end) is a finite decimal number and nothing else.  Up to 2^53 times a power of ten up to 10^22 is one
   rounding of two exact doubles, so correct (Clinger 1990, "How to read floating point numbers accurately"). */
static int pbwio__number(const char *s, const char *end, double *value)
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
        } else if (*s == '.' && !point) {
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
    *value = pbwio__long_number(begin, digits_end, written);
    return *value <= DBL_MAX && *value >= -DBL_MAX;
}

/* The digits d.ddd times 10^exponent as text; returns the length. */
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

/* Writes x in the fewest digits from 15 to 17 that read back the same; returns the length. */
static int pbwio__print_number(char text[40], double x)
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
    while (count > 15) {
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
        if (!pbwio__number(shorter, shorter + other, &back) || back < x || back > x) {
            break;
        }
        memcpy(text, shorter, (size_t)other);
        length = other;
    }
    return length;
}

/* ------------------------------------------------------------------------------------------------------
   The reader: lines, fields, points, triangles.
   In: the whole file in memory.  Out: a cloud.  Holds: every pointer stays in [begin, end]; held <= budget.
   The first failure stays in status; from then on there are no more lines and fields, so that loops end.
   ------------------------------------------------------------------------------------------------------ */
#define PBWIO__MOST_COLUMNS 256

typedef struct pbwio__field { const char *begin, *end; } pbwio__field;

typedef struct pbwio__reader {
    pbwio_status status;
    const char *name, *begin, *at, *end;     /* at: where the next line or binary value starts */
    const char *line, *line_end, *cursor;    /* the current line without its end; where its next field starts */
    size_t line_number;                      /* 0 where there are no lines: in binary data */
    int separator;                           /* ',' or ';', 0 = blanks */
    int joined, over;                        /* this line is continued with backslashes; has no more fields */
    int column[4], last_column;              /* where x, y, z and the weight are, from 0; -1 = nowhere */
    const pbwio_options *options;
    pbwio_cloud *cloud;
    size_t point_capacity, triangle_capacity, held, budget;
    size_t fan[2];                           /* the first and the last corner of the polygon at hand */
    pbwio_error *error;
} pbwio__reader;

PBWIO__PRINTF(3, 4)
static void pbwio__fail(pbwio__reader *r, pbwio_status status, const char *format, ...)
{
    char place[40];
    va_list list;
    if (r->status != PBWIO_OK) {
        return;
    }
    if (r->line_number != 0) {
        snprintf(place, sizeof place, ":%zu:", r->line_number);
    } else {
        snprintf(place, sizeof place, ": byte %zu:", (size_t)(r->at - r->begin));
    }
    va_start(list, format);
    pbwio__message(r->error, r->name, place, format, list);
    va_end(list);
    r->status = status;
}

/* Blocks within the budget; while a block grows, both its sizes count. */
static void *pbwio__resize(pbwio__reader *r, void *ptr, size_t old_count, size_t count, size_t size)
{
    void *block = NULL;
    if (count <= r->budget / size && count * size <= r->budget - r->held) {
        block = PBWIO_REALLOC(ptr, count * size);
    }
    if (block == NULL) {
        pbwio__fail(r, PBWIO_ERROR_MEMORY, "out of memory, or over 8 times the size of the file");
        return NULL;
    }
    r->held = r->held + count * size - old_count * size;
    return block;
}

static int pbwio__line(pbwio__reader *r)
{
    const char *stop;
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

static int pbwio__is(pbwio__field field, const char *word)
{
    return pbwio__same(field.begin, (size_t)(field.end - field.begin), word, strlen(word));
}

/* A field for a message: short, and without bytes that a terminal would act on. */
static const char *pbwio__show(pbwio__field field, char text[32])
{
    size_t length = (size_t)(field.end - field.begin), i;
    for (i = 0; i < length && i < 24; i++) {
        text[i] = field.begin[i] >= ' ' && field.begin[i] <= '~' ? field.begin[i] : '?';
    }
    strcpy(text + i, length > 24 ? "..." : "");
    return text;
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
    char text[32];
    if (!pbwio__next(r, &field)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the line ends where the %s should be", what);
    } else if (!pbwio__natural(field, &value)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a %s", pbwio__show(field, text), what);
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

/* Decides which columns are x, y, z and the weight.  names: of the columns, name_count of them, NULL = x y z;
   column_count: how many columns a row has, 0 = three or more, the rows will tell. */
static void pbwio__choose(pbwio__reader *r, const pbwio__field *names, int name_count, int column_count)
{
    static const char letters[] = "xyz";
    const pbwio_options *o = r->options;
    pbwio__field xyz[3];
    const char *s;
    int dim = 0, i, k, *column = r->column, weight = -1;
    for (k = 0; k < 3; k++) {
        xyz[k].begin = letters + k;
        xyz[k].end = letters + k + 1;
        column[k] = -1;
    }
    names = names == NULL ? xyz : names;
    if (o->weight != NULL && (weight = pbwio__find(names, name_count, o->weight, strlen(o->weight))) < 0) {
        pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "there is no column \"%.40s\"", o->weight);
    }
    if (o->columns != NULL) {
        for (s = o->columns; dim < 3; s++) {
            size_t length = strcspn(s, ",");
            column[dim] = pbwio__find(names, name_count, s, length);
            if (column[dim++] < 0) {
                pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "there is no column \"%.*s\"", length < 40 ? (int)length : 40,
                            s);
            }
            s += length;
            if (*s == 0) {
                break;
            }
        }
    } else if (pbwio__find(names, name_count, "x", 1) >= 0 && pbwio__find(names, name_count, "y", 1) >= 0) {
        for (k = 0; k < 3; k++) {
            column[k] = pbwio__find(names, name_count, letters + k, 1);
            dim += column[k] >= 0;
        }
    } else {
        for (i = 0; i < (column_count == 0 ? 3 : column_count) && dim < 3; i++) {
            if (i != weight) {
                column[dim++] = i;
            }
        }
    }
    if (dim < 2 || dim < o->dim) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%d coordinates where %d are needed", dim, o->dim > 2 ? o->dim : 2);
    }
    if (o->dim == 2) {
        dim = 2;
        column[2] = -1;
    }
    column[3] = weight;
    r->cloud->dim = dim;
    for (k = 0, r->last_column = 0; k < 4; k++) {
        r->last_column = column[k] > r->last_column ? column[k] : r->last_column;
    }
    if (column_count != 0 && r->last_column >= column_count) {
        pbwio__fail(r, PBWIO_ERROR_ARGUMENT, "column %d is asked for, there are %d", r->last_column + 1,
                    column_count);
    }
}

/* Room for the points of the rest of the file.  smallest: the fewest bytes that a point takes there; a file that
   announces more points than it has bytes for gets no memory for them. */
static void pbwio__reserve(pbwio__reader *r, unsigned long long announced, size_t smallest)
{
    size_t left = (size_t)(r->end - r->at), dim = (size_t)r->cloud->dim, count;
    if (r->status == PBWIO_OK && announced > (left + 1) / smallest) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%llu points are announced, %zu bytes follow", announced, left);
    }
    if (r->status == PBWIO_OK && announced >= PBW_NONE) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "more than %lu points", (unsigned long)PBW_NONE - 1);
    }
    if (r->status != PBWIO_OK || announced == 0) {
        return;
    }
    count = (size_t)announced;
    r->point_capacity = count;
    r->cloud->points = (double *)pbwio__resize(r, NULL, 0, count, dim * sizeof(double));
    if (r->column[3] >= 0 && r->status == PBWIO_OK) {
        r->cloud->weights = (double *)pbwio__resize(r, NULL, 0, count, sizeof(double));
    }
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
        cloud->count++;
    }
}

/* Reads a point from the fields of the line that are left. */
static void pbwio__point(pbwio__reader *r)
{
    double value[4];
    pbwio__field field;
    char text[32];
    int i, k;
    for (i = 0; i <= r->last_column; i++) {
        if (!pbwio__next(r, &field)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "%d column%s where %d are needed", i, i == 1 ? "" : "s",
                        r->last_column + 1);
            return;
        }
        for (k = 0; k < 4; k++) {
            if (r->column[k] == i && !pbwio__number(field.begin, field.end, &value[k])) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "column %d, \"%s\", is not a finite number", i + 1,
                            pbwio__show(field, text));
            }
        }
    }
    pbwio__add_point(r, value);
}

static void pbwio__add_triangle(pbwio__reader *r, size_t a, size_t b, size_t c)
{
    pbwio_cloud *cloud = r->cloud;
    pbw_index *corner;
    if (cloud->triangle_count == r->triangle_capacity) {
        size_t capacity = r->triangle_capacity + r->triangle_capacity / 2 + 64;
        void *block = pbwio__resize(r, cloud->triangles, r->triangle_capacity, capacity, 3 * sizeof(pbw_index));
        if (block == NULL) {
            return;
        }
        cloud->triangles = (pbw_index *)block;
        r->triangle_capacity = capacity;
    }
    corner = cloud->triangles + 3 * cloud->triangle_count++;
    corner[0] = (pbw_index)a;
    corner[1] = (pbw_index)b;
    corner[2] = (pbw_index)c;
}

/* The k-th corner of a polygon; from the third on each makes a triangle. */
static void pbwio__add_corner(pbwio__reader *r, double id, long long point_count, long long k)
{
    if (!(id >= 0 && id < (double)point_count && id == floor(id))) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "a face has point %.17g, there are %lld (from 0)", id, point_count);
    } else {
        if (k >= 2) {
            pbwio__add_triangle(r, r->fan[0], r->fan[1], (size_t)id);
        }
        r->fan[k > 0] = (size_t)id;
    }
}

/* ------------------------------------------------------------------------------------------------------
   Formats where a point is a line: tables, .node, .obj, .off.
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

/* The first lines tell the separator, the names and the number of columns: a first line in which nothing starts like
   a number is a header; a first line that is one whole number is the count that .pts files start with. */
static void pbwio__read_table(pbwio__reader *r)
{
    pbwio__field names[PBWIO__MOST_COLUMNS], columns[PBWIO__MOST_COLUMNS];
    int name_count = 0, count, numbers, first;
    long long announced;
    for (first = 1; pbwio__row_line(r); first = 0) {
        if (first) {
            size_t length = (size_t)(r->line_end - r->line);
            r->separator = memchr(r->line, ';', length) ? ';' : memchr(r->line, ',', length) ? ',' : 0;
        }
        for (count = numbers = 0; count < PBWIO__MOST_COLUMNS && pbwio__next(r, &columns[count]); count++) {
            const char *s = columns[count].begin;
            numbers += s < columns[count].end && memchr("+-.0123456789", *s, 13) != NULL;
        }
        if (first && numbers == 0) {
            memcpy(names, columns, sizeof columns);
            name_count = count;
        } else if (!(first && count == 1 && pbwio__natural(columns[0], &announced))) {
            pbwio__choose(r, names, name_count, count);
            r->at = r->line;
            r->line_number--;
            pbwio__reserve(r, pbwio__most(r, pbwio__count_lines(r, 0)), 1);
            while (pbwio__row_line(r)) {
                pbwio__point(r);
            }
        }
    }
}

/* "count dim attributes markers", then "id x y (z) attributes marker" with ids from 0 or 1. */
static void pbwio__read_node(pbwio__reader *r)
{
    long long count, dim, attributes, markers, first = 0, id, i;
    pbwio__row_line(r);
    count = pbwio__count(r, "number of points");
    dim = pbwio__count(r, "dimension");
    attributes = pbwio__count(r, "number of attributes");
    markers = pbwio__count(r, "number of markers");
    if (dim < 2 || dim > 3 || attributes > 1000 || markers > 1) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "dimension %lld, %lld attributes, %lld markers", dim, attributes, markers);
        return;
    }
    pbwio__choose(r, NULL, (int)dim, (int)(dim + attributes + markers));
    pbwio__reserve(r, (unsigned long long)count, 2 * (size_t)(dim + attributes + markers + 1));
    for (i = 0; i < count && r->status == PBWIO_OK; i++) {
        if (!pbwio__row_line(r)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends after %lld of %lld points", i, count);
        }
        id = pbwio__count(r, "point number");
        first = i == 0 && id == 1 ? 1 : first;
        if (id != first + i) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "point number %lld where %lld is due", id, first + i);
        }
        pbwio__point(r);
    }
}

/* A face corner is id, id/texture, id//normal or id/texture/normal; ids start at 1, -1 is the last point so far. */
static void pbwio__read_obj(pbwio__reader *r)
{
    pbwio__field field, number;
    long long total, id, k;
    char text[32];
    pbwio__choose(r, NULL, 3, 0);
    pbwio__reserve(r, pbwio__most(r, pbwio__count_lines(r, 'v')), 1);
    total = (long long)r->point_capacity;
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
        if (pbwio__is(field, "v")) {
            pbwio__point(r);
        } else if (pbwio__is(field, "f")) {
            for (k = 0; pbwio__next(r, &field); k++) {
                int minus = *field.begin == '-';
                number.begin = number.end = field.begin + minus;
                while (number.end < field.end && *number.end != '/') {
                    number.end++;
                }
                if (!pbwio__natural(number, &id) || id == 0) {
                    pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is no corner of a face", pbwio__show(field, text));
                } else if (id > (minus ? (long long)r->cloud->count : total)) {
                    pbwio__fail(r, PBWIO_ERROR_FORMAT, "a face has point %s, there are %lld",
                                pbwio__show(field, text), minus ? (long long)r->cloud->count : total);
                } else {
                    pbwio__add_corner(r, (double)(minus ? (long long)r->cloud->count - id : id - 1), total, k);
                }
            }
            if (k < 3) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "a face of %lld corners", k);
            }
        } else if (memchr(field.begin, 0, (size_t)(field.end - field.begin)) != NULL) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "a zero byte: this is not text");
        }
    }
    if (r->cloud->count < r->point_capacity && r->cloud->triangle_count != 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%zu points where %zu are announced", r->cloud->count, r->point_capacity);
    }
}

/* "OFF", with letters before it for colours, normals, texture: columns after z; the counts; the points; the faces. */
static void pbwio__read_off(pbwio__reader *r)
{
    long long points, faces, corners, i, k;
    pbwio__field field;
    char text[32];
    pbwio__row_line(r);
    pbwio__next(r, &field);
    if (field.end - field.begin >= 3 && pbwio__same(field.end - 3, 3, "OFF", 3)) {       /* the word may be missing */
        for (; field.end - field.begin > 3; field.begin++) {
            if (memchr("STCN", *field.begin, 4) == NULL) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "files of kind \"%s\" are not read", pbwio__show(field, text));
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
   Formats with binary forms: .stl, .ply.
   ------------------------------------------------------------------------------------------------------ */
static const struct { const char *name, *old_name; size_t size; } pbwio__types[] = {
    { "int8", "char", 1 }, { "uint8", "uchar", 1 }, { "int16", "short", 2 }, { "uint16", "ushort", 2 },
    { "int32", "int", 4 }, { "uint32", "uint", 4 }, { "float32", "float", 4 }, { "float64", "double", 8 }
};

/* The next value of a type out of the table, in the byte order of the file. */
static double pbwio__binary(pbwio__reader *r, int type, int big)
{
    size_t size = pbwio__types[type].size, i;
    uint64_t bits = 0;
    uint32_t low;
    double x;
    float f;
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
    size_t i, n;
    int k;
    r->at += 84;
    r->line_number = 0;
    if ((size_t)(r->end - r->at) / 50 < count) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "%zu triangles are announced, %zu bytes follow", count,
                    (size_t)(r->end - r->at));
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

/* A binary file may start with "solid" as a text file does, so the length decides. */
static void pbwio__read_stl(pbwio__reader *r)
{
    size_t size = (size_t)(r->end - r->at), count = 0, corners = 0, n;
    pbwio__reader head = *r;
    pbwio__field field;
    pbwio__choose(r, NULL, 3, 3);
    if (size >= 84) {
        head.at += 80;
        count = (size_t)pbwio__binary(&head, 5, 0);
        if (size == 84 + 50 * (unsigned long long)count || memcmp(r->at, "solid", 5) != 0) {
            pbwio__read_stl_binary(r, count);
            return;
        }
    }
    pbwio__reserve(r, pbwio__most(r, pbwio__count_lines(r, 0)), 1);
    while (pbwio__row_line(r)) {
        pbwio__next(r, &field);
        if (pbwio__is(field, "vertex")) {
            pbwio__point(r);
            corners++;
        } else if (pbwio__is(field, "endloop") || pbwio__is(field, "facet") || pbwio__is(field, "endsolid")) {
            if (corners != 0 && corners != 3) {
                pbwio__fail(r, PBWIO_ERROR_FORMAT, "a facet of %zu corners", corners);
            } else if (corners == 3) {
                n = r->cloud->count;
                pbwio__add_triangle(r, n - 3, n - 2, n - 1);
            }
            corners = 0;
        }
    }
    if (corners != 0) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends inside a facet");
    }
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
    char text[32];
    double value = 0;
    if (!ply->text) {
        value = pbwio__binary(r, type, ply->big);
        if (wanted && !pbwio__finite(value)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "a value is not a finite number");
        }
    } else if (!pbwio__next(r, &field)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "the line has too few values");
    } else if (wanted && !pbwio__number(field.begin, field.end, &value)) {
        pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a finite number", pbwio__show(field, text));
    }
    return value;
}

static void pbwio__ply_element(pbwio__reader *r, const pbwio__ply *ply)
{
    int vertex = pbwio__is(ply->name, "vertex"), face = pbwio__is(ply->name, "face"), lists = 0, p, k, corners;
    size_t row = 0;                          /* the fewest bytes of one element */
    double value[4] = { 0, 0, 0, 0 }, length, x;
    pbwio__field names[PBWIO__MOST_COLUMNS];
    char text[32];
    long long i, j;
    for (p = 0; p < ply->property_count; p++) {
        const pbwio__property *property = &ply->property[p];
        names[p] = property->name;
        lists |= property->list >= 0;
        row += ply->text ? 2 : pbwio__types[property->list >= 0 ? property->list : property->type].size;
    }
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
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends inside element \"%s\"", pbwio__show(ply->name, text));
            return;
        }
        r->at += (size_t)ply->count * row;
        return;
    }
    for (i = 0; i < ply->count && r->status == PBWIO_OK; i++) {
        if (ply->text && !pbwio__row_line(r)) {
            pbwio__fail(r, PBWIO_ERROR_FORMAT, "the file ends after %lld of %lld of element \"%s\"", i, ply->count,
                        pbwio__show(ply->name, text));
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
    char text[32];
    int t;
    pbwio__next(r, &field);
    for (t = 0; t < 8; t++) {
        if (pbwio__is(field, pbwio__types[t].name) || pbwio__is(field, pbwio__types[t].old_name)) {
            return t;
        }
    }
    pbwio__fail(r, PBWIO_ERROR_FORMAT, "\"%s\" is not a type", pbwio__show(field, text));
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
    char text[32];
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
            pbwio__fail(&header, PBWIO_ERROR_FORMAT, "\"%s\" is no header line", pbwio__show(word, text));
        }
        r->status = r->status == PBWIO_OK ? header.status : r->status;
    }
}

/* ------------------------------------------------------------------------------------------------------
   Reading: which format, the whole file, the verdict.
   ------------------------------------------------------------------------------------------------------ */

/* The format that the content looks like: a first word that only one format has, else a table. */
static pbwio_format pbwio__sniff(pbwio__reader r)
{
    pbwio__reader head = r;
    pbwio__field word;
    r.error = head.error = NULL;
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
        return pbwio__is(word, "ply") ? PBWIO_PLY : pbwio__is(word, "solid") ? PBWIO_STL
             : word.end - word.begin >= 3 && pbwio__same(word.end - 3, 3, "OFF", 3) ? PBWIO_OFF : PBWIO_XYZ;
    }
    return PBWIO_XYZ;
}

PBWIODEF void pbwio_free(pbwio_cloud *cloud)
{
    if (cloud != NULL) {
        PBWIO_FREE(cloud->points);
        PBWIO_FREE(cloud->weights);
        PBWIO_FREE(cloud->triangles);
        memset(cloud, 0, sizeof *cloud);
    }
}

/* What was reserved and not used goes back; a block that cannot shrink is fine as it is. */
static void *pbwio__shrink(void *ptr, size_t size)
{
    void *block = ptr != NULL && size != 0 ? PBWIO_REALLOC(ptr, size) : NULL;
    return block != NULL ? block : ptr;
}

PBWIODEF pbwio_status pbwio_read_memory(const char *name, const void *data, size_t size, const pbwio_options *options,
                                        pbwio_cloud *cloud, pbwio_error *error)
{
    static const pbwio_options defaults = { PBWIO_AUTO, 0, NULL, NULL };
    const char *wrong = NULL;
    pbwio_format format;
    pbwio__reader r;
    size_t left;
    if (cloud == NULL || name == NULL || (data == NULL && size != 0)) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, "pbwio_read_memory", "an argument is NULL");
    }
    memset(cloud, 0, sizeof *cloud);
    memset(&r, 0, sizeof r);
    r.name = name;
    r.begin = r.at = r.line = r.line_end = r.cursor = size == 0 ? "" : (const char *)data;
    r.end = r.begin + size;
    r.options = options == NULL ? &defaults : options;
    r.cloud = cloud;
    r.error = error;
    r.budget = (size > (size_t)-1 / 16 ? (size_t)-1 / 2 : 8 * size) + 65536;
    if (r.options->dim != 0 && r.options->dim != 2 && r.options->dim != 3) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, name, "dimension %d is not 2 or 3", r.options->dim);
    }
    if (size >= 3 && memcmp(r.at, "\xef\xbb\xbf", 3) == 0) {
        r.at += 3;                                                   /* UTF-8 byte order mark */
    }
    format = r.options->format != PBWIO_AUTO ? r.options->format : pbwio_format_of(name);
    format = format != PBWIO_AUTO ? format : pbwio__sniff(r);
    left = (size_t)(r.end - r.at);
    if (left == 0) {
        wrong = "the file is empty";
    } else if (left >= 2 && memcmp(r.at, "\x1f\x8b", 2) == 0) {
        wrong = "the file is compressed: unpack it first";
    } else if (left >= 2 && (memcmp(r.at, "\xff\xfe", 2) == 0 || memcmp(r.at, "\xfe\xff", 2) == 0)) {
        wrong = "the file is UTF-16 text: save it as UTF-8";
    } else if (format != PBWIO_STL && memchr(r.at, '\n', left) == NULL && memchr(r.at, '\r', left) != NULL) {
        wrong = "lines end with CR alone: convert them to LF or CR LF";
    }
    if (wrong != NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_FORMAT, name, "%s", wrong);
    }
    switch (format) {
        case PBWIO_OBJ: pbwio__read_obj(&r); break;
        case PBWIO_PLY: pbwio__read_ply(&r); break;
        case PBWIO_STL: pbwio__read_stl(&r); break;
        case PBWIO_OFF: pbwio__read_off(&r); break;
        case PBWIO_NODE: pbwio__read_node(&r); break;
        case PBWIO_XYZ:
        case PBWIO_CSV: pbwio__read_table(&r); break;
        default: return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, name, "this format is written, not read");
    }
    if (r.status == PBWIO_OK && cloud->count == 0) {
        r.status = pbwio__file_error(error, PBWIO_ERROR_FORMAT, name, "the file has no points");
    }
    if (r.status != PBWIO_OK) {
        pbwio_free(cloud);
        return r.status;
    }
    cloud->points = (double *)pbwio__shrink(cloud->points, cloud->count * (size_t)cloud->dim * sizeof(double));
    cloud->weights = (double *)pbwio__shrink(cloud->weights, cloud->count * sizeof(double));
    cloud->triangles = (pbw_index *)pbwio__shrink(cloud->triangles, cloud->triangle_count * 3 * sizeof(pbw_index));
    return PBWIO_OK;
}

PBWIODEF pbwio_status pbwio_read(const char *path, const pbwio_options *options, pbwio_cloud *cloud,
                                 pbwio_error *error)
{
    int standard = path != NULL && strcmp(path, "-") == 0;
    size_t size = 0, capacity = 0, got = 1;
    char *data = NULL, *block;
    pbwio_status status;
    FILE *file;
    if (path == NULL || cloud == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, "pbwio_read", "an argument is NULL");
    }
    memset(cloud, 0, sizeof *cloud);
    file = standard ? stdin : fopen(path, "rb");
    if (file == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_FILE, path, "%s", strerror(errno));
    }
    while (got != 0) {
        if (size == capacity) {
            capacity = capacity == 0 ? 65536 : 2 * capacity;
            block = capacity > size ? (char *)PBWIO_REALLOC(data, capacity) : NULL;
            if (block == NULL) {
                break;
            }
            data = block;
        }
        got = fread(data + size, 1, capacity - size, file);
        size += got;
    }
    if (got != 0) {
        status = pbwio__file_error(error, PBWIO_ERROR_MEMORY, path, "out of memory");
    } else if (ferror(file)) {
        status = pbwio__file_error(error, PBWIO_ERROR_FILE, path, "%s", strerror(errno));
    } else {
        data = (char *)pbwio__shrink(data, size);
        status = pbwio_read_memory(standard ? "standard input" : path, data, size, options, cloud, error);
    }
    PBWIO_FREE(data);
    if (!standard) {
        fclose(file);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   The writer: values in text or binary, points, simplices and facets of the hull.
   In: a mesh.  Out: a stream; the first failure of the stream stays in it and is found when it is closed.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwio__writer {
    const pbw_mesh *mesh;
    const pbwio_output *output;
    pbwio_format format;
    FILE *file;
    int text, between;                       /* text: values are followed by the character between */
    size_t id_size;                          /* bytes of a point id in binary */
    size_t corners;                          /* of a simplex: dim+1 */
    pbw_index *number;                       /* of a point or simplex in the file; PBW_NONE: left out; NULL: itself */
    size_t point_count, cell_count, facet_count;     /* what the file holds */
    size_t used;
    char buffer[16384];
} pbwio__writer;

/* Facet k is across from corner k and turns counter-clockwise seen from outside. */
static const unsigned char pbwio__facet2[3][2] = { { 1, 2 }, { 2, 0 }, { 0, 1 } };
static const unsigned char pbwio__facet3[4][3] = { { 1, 2, 3 }, { 0, 3, 2 }, { 0, 1, 3 }, { 0, 2, 1 } };

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
    digits[--at] = (char)w->between;
    do {
        digits[--at] = (char)('0' + rest % 10);
        rest /= 10;
    } while (rest != 0);
    if (value < 0) {
        digits[--at] = '-';
    }
    pbwio__put(w, digits + at, sizeof digits - at);
}

static void pbwio__real(pbwio__writer *w, double x)
{
    char text[48];
    int length;
    if (!w->text) {
        pbwio__put(w, &x, sizeof x);
        return;
    }
    length = pbwio__print_number(text, x);
    text[length] = (char)w->between;
    pbwio__put(w, text, (size_t)length + 1);
}

static void pbwio__end_line(pbwio__writer *w)                        /* in place of what follows the last value */
{
    if (w->text) {
        w->used -= w->used > 0;
        pbwio__put(w, "\n", 1);
    }
}

static int pbwio__kept(const pbwio__writer *w, size_t simplex)
{
    return w->output->keep == NULL || w->output->keep[simplex] != 0;
}

static int pbwio__on_hull(const pbwio__writer *w, size_t simplex, size_t k)
{
    pbw_index other = w->mesh->neighbors[w->corners * simplex + k];
    return other == PBW_NONE || !pbwio__kept(w, other);
}

/* The corners of facet k, or of the simplex itself where k is w->corners; returns how many. */
static size_t pbwio__corners(const pbwio__writer *w, size_t simplex, size_t k, pbw_index corner[4])
{
    const pbw_index *all = w->mesh->simplices + w->corners * simplex;
    size_t i, count = w->corners - (k < w->corners);
    for (i = 0; i < count; i++) {
        corner[i] = all[k == w->corners ? i : w->corners == 4 ? pbwio__facet3[k][i] : pbwio__facet2[k][i]];
    }
    return count;
}

/* Goes through the simplices that are kept, or through the facets of their hull: *simplex and *k are the next ones
   after themselves; start with 0 and -1. */
static int pbwio__step(const pbwio__writer *w, int facets, size_t *simplex, size_t *k)
{
    if (!facets) {
        for (*simplex += *k == w->corners, *k = w->corners; *simplex < w->mesh->simplex_count; ++*simplex) {
            if (pbwio__kept(w, *simplex)) {
                return 1;
            }
        }
        return 0;
    }
    for (++*k; *simplex < w->mesh->simplex_count; ++*simplex, *k = 0) {
        for (; *k < w->corners && pbwio__kept(w, *simplex); ++*k) {
            if (pbwio__on_hull(w, *simplex, *k)) {
                return 1;
            }
        }
    }
    return 0;
}

/* Numbers the points that the file will hold: all, or the corners of what is written. */
static int pbwio__number_points(pbwio__writer *w, int all, int facets)
{
    size_t i, n, count, simplex = 0, k = (size_t)-1;
    pbw_index corner[4];
    w->point_count = w->mesh->point_count;
    if (all || w->point_count == 0) {
        return 1;
    }
    w->number = (pbw_index *)PBWIO_REALLOC(NULL, w->point_count * sizeof *w->number);
    if (w->number == NULL) {
        return 0;
    }
    memset(w->number, 0xff, w->point_count * sizeof *w->number);
    while (pbwio__step(w, facets, &simplex, &k)) {
        for (i = 0, n = pbwio__corners(w, simplex, k, corner); i < n; i++) {
            w->number[corner[i]] = 0;
        }
    }
    for (i = count = 0; i < w->mesh->point_count; i++) {
        w->number[i] = w->number[i] == PBW_NONE ? PBW_NONE : (pbw_index)count++;
    }
    w->point_count = count;
    return 1;
}

/* The points, each after a word and its number (-1: none), as width coordinates, those that it lacks 0, and the
   weight if wanted. */
static void pbwio__points(pbwio__writer *w, const char *before, long long number, size_t width, int weights)
{
    size_t i, k, dim = (size_t)w->mesh->dim;
    for (i = 0; i < w->mesh->point_count; i++) {
        if (w->number == NULL || w->number[i] != PBW_NONE) {
            pbwio__put(w, before, strlen(before));
            if (number >= 0) {
                pbwio__int(w, number++, 8);
            }
            for (k = 0; k < width; k++) {
                pbwio__real(w, k < dim ? w->mesh->points[dim * i + k] : 0.0);
            }
            if (weights && w->mesh->weights != NULL) {
                pbwio__real(w, w->mesh->weights[i]);
            }
            pbwio__end_line(w);
        }
    }
}

/* The simplices or the facets, each after a word and its number (-1: none), as ids that start at base, and a mark
   (-1: none). */
static void pbwio__cells(pbwio__writer *w, int facets, const char *before, long long number, unsigned base, int mark)
{
    size_t i, n, simplex = 0, k = (size_t)-1;
    pbw_index corner[4];
    while (pbwio__step(w, facets, &simplex, &k)) {
        pbwio__put(w, before, strlen(before));
        if (number >= 0) {
            pbwio__int(w, number++, 8);
        }
        for (i = 0, n = pbwio__corners(w, simplex, k, corner); i < n; i++) {
            pbwio__int(w, (long long)(w->number == NULL ? corner[i] : w->number[corner[i]]) + base, w->id_size);
        }
        if (mark >= 0) {
            pbwio__int(w, mark, 4);
        }
        pbwio__end_line(w);
    }
}

/* Mean ratio: 12 (3 volume)^(2/3) or 4 sqrt(3) area, over the sum of the squared edge lengths. */
static double pbwio__quality(const pbw_mesh *mesh, size_t simplex)
{
    size_t dim = (size_t)mesh->dim, n = dim + 1, i, j, k;
    const pbw_index *corner = mesh->simplices + n * simplex;
    double edge[3][3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 1 } }, sum = 0, d, size;
    for (i = 0; i < n; i++) {
        for (j = i + 1; j < n; j++) {
            for (k = 0; k < dim; k++) {
                d = mesh->points[dim * corner[j] + k] - mesh->points[dim * corner[i] + k];
                edge[j - 1][k] = i == 0 ? d : edge[j - 1][k];
                sum += d * d;
            }
        }
    }
    size = edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1])
         - edge[0][1] * (edge[1][0] * edge[2][2] - edge[1][2] * edge[2][0])
         + edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0]);
    size = size > 0 ? size : 0;                                      /* 6 volumes or 2 areas; may round below 0 */
    d = dim == 3 ? 12 * pow(size / 2, 2.0 / 3.0) / sum : 2 * sqrt(3.0) * size / sum;
    return d >= 0 && d <= 1 ? d : d > 1 ? 1 : 0;
}

/* ------------------------------------------------------------------------------------------------------
   The formats that are written.
   ------------------------------------------------------------------------------------------------------ */

static int pbwio__little_endian(void)
{
    const uint32_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 1;
}

/* One array of a .vtu file.  pass 0: its tag, in text with its numbers; pass 1: its numbers.  kind: what they are;
   bytes: how many in binary; *offset: where they start there. */
static void pbwio__vtu_array(pbwio__writer *w, int pass, char kind, const char *type, const char *name,
                             unsigned long long bytes, unsigned long long *offset)
{
    const pbw_mesh *mesh = w->mesh;
    size_t i, n = 0;
    if (pass == 0) {
        pbwio__print(w, "<DataArray type=\"%s\" Name=\"%.200s\" NumberOfComponents=\"%d\" ", type, name,
                     kind == 'p' ? 3 : 1);
        if (!w->text) {
            pbwio__print(w, "format=\"appended\" offset=\"%llu\"/>\n", *offset);
            *offset += 8 + bytes;
            return;
        }
        pbwio__print(w, "format=\"ascii\">\n");
    } else {
        pbwio__int(w, (long long)bytes, 8);
    }
    if (kind == 'p') {
        pbwio__points(w, "", -1, 3, 0);
    } else if (kind == 'c') {
        pbwio__cells(w, 0, "", -1, 0, -1);
    }
    for (i = 0; i < mesh->point_count && (kind == 'i' || kind == 'w'); i++) {
        if (w->number == NULL || w->number[i] != PBW_NONE) {
            if (kind == 'i') {
                pbwio__int(w, (long long)i, 4);
            } else {
                pbwio__real(w, mesh->weights[i]);
            }
            pbwio__end_line(w);
        }
    }
    for (i = 0; i < mesh->simplex_count && strchr("qvot", kind) != NULL; i++) {
        if (pbwio__kept(w, i)) {
            if (kind == 'q' || kind == 'v') {
                pbwio__real(w, kind == 'q' ? pbwio__quality(mesh, i) : w->output->values[i]);
            } else {
                n += w->corners;
                pbwio__int(w, kind == 'o' ? (long long)n : mesh->dim == 3 ? 10 : 5, kind == 'o' ? 8 : 1);
            }
            pbwio__end_line(w);
        }
    }
    if (w->text) {
        pbwio__print(w, "</DataArray>\n");
    }
}

static void pbwio__write_vtu(pbwio__writer *w)
{
    unsigned long long points = w->point_count, cells = w->cell_count, offset = 0;
    const char *name = w->output->value_name == NULL ? "value" : w->output->value_name;
    int pass;
    pbwio__print(w, "<?xml version=\"1.0\"?>\n"
                 "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"%s\" header_type=\"UInt64\">\n"
                 "<UnstructuredGrid>\n<Piece NumberOfPoints=\"%llu\" NumberOfCells=\"%llu\">\n",
                 pbwio__little_endian() ? "LittleEndian" : "BigEndian", points, cells);
    for (pass = 0; pass < 2 - w->text; pass++) {                     /* binary: all tags, then all numbers */
        pbwio__print(w, "%s", pass == 0 ? "<PointData>\n" : "<AppendedData encoding=\"raw\">\n_");
        pbwio__vtu_array(w, pass, 'i', "UInt32", "id", 4 * points, &offset);
        if (w->mesh->weights != NULL) {
            pbwio__vtu_array(w, pass, 'w', "Float64", "weight", 8 * points, &offset);
        }
        pbwio__print(w, "%s", pass == 0 ? "</PointData>\n<CellData>\n" : "");
        pbwio__vtu_array(w, pass, 'q', "Float64", "quality", 8 * cells, &offset);
        if (w->output->values != NULL) {
            pbwio__vtu_array(w, pass, 'v', "Float64", name, 8 * cells, &offset);
        }
        pbwio__print(w, "%s", pass == 0 ? "</CellData>\n<Points>\n" : "");
        pbwio__vtu_array(w, pass, 'p', "Float64", "points", 24 * points, &offset);
        pbwio__print(w, "%s", pass == 0 ? "</Points>\n<Cells>\n" : "");
        pbwio__vtu_array(w, pass, 'c', "UInt32", "connectivity", 4 * cells * w->corners, &offset);
        pbwio__vtu_array(w, pass, 'o', "Int64", "offsets", 8 * cells, &offset);
        pbwio__vtu_array(w, pass, 't', "UInt8", "types", cells, &offset);
        pbwio__print(w, "%s", pass == 0 ? "</Cells>\n</Piece>\n</UnstructuredGrid>\n" : "\n</AppendedData>\n");
    }
    pbwio__print(w, "</VTKFile>\n");
}

/* An entity of a .msh file: its tag, its bounding box, its physical group; bounded by one entity or by none. */
static void pbwio__msh_entity(pbwio__writer *w, const double box[6], int group, int bounded)
{
    int i;
    pbwio__int(w, 1, 4);
    for (i = 0; i < 6; i++) {
        pbwio__real(w, box[i]);
    }
    pbwio__int(w, 1, 8);
    pbwio__int(w, group, 4);
    pbwio__int(w, bounded, 8);
    if (bounded) {
        pbwio__int(w, 1, 4);
    }
    pbwio__end_line(w);
}

/* The four numbers that start a section or a block. */
static void pbwio__msh_head(pbwio__writer *w, unsigned long long a, unsigned long long b, unsigned long long c,
                            unsigned long long d, size_t size)
{
    pbwio__int(w, (long long)a, size);
    pbwio__int(w, (long long)b, size);
    pbwio__int(w, (long long)c, size);
    pbwio__int(w, (long long)d, 8);
    pbwio__end_line(w);
}

/* Entity 1 of dimension dim holds the simplices and all points, entity 1 of dimension dim-1 the hull. */
static void pbwio__write_msh(pbwio__writer *w)
{
    const pbw_mesh *mesh = w->mesh;
    unsigned dim = (unsigned)mesh->dim, type = dim == 3 ? 4 : 2, facet_type = dim == 3 ? 2 : 1;
    size_t i, k, facets = w->facet_count, blocks = (facets != 0) + (size_t)1;
    double box[6] = { 0, 0, 0, 0, 0, 0 };
    for (i = 0; i < mesh->point_count; i++) {
        for (k = 0; k < dim; k++) {
            double x = mesh->points[dim * i + k];
            box[k] = i == 0 || x < box[k] ? x : box[k];
            box[3 + k] = i == 0 || x > box[3 + k] ? x : box[3 + k];
        }
    }
    pbwio__print(w, "$MeshFormat\n4.1 %d 8\n", !w->text);
    if (!w->text) {
        pbwio__int(w, 1, 4);
        pbwio__print(w, "\n");
    }
    pbwio__print(w, "$EndMeshFormat\n$PhysicalNames\n2\n%u 1 \"hull\"\n%u 2 \"simplices\"\n$EndPhysicalNames\n"
                 "$Entities\n", dim - 1, dim);
    pbwio__msh_head(w, 0, dim == 2, 1, dim == 3, 8);
    pbwio__msh_entity(w, box, 1, 0);
    pbwio__msh_entity(w, box, 2, 1);
    pbwio__print(w, "%s$EndEntities\n$Nodes\n", w->text ? "" : "\n");
    pbwio__msh_head(w, 1, w->point_count, 1, w->point_count, 8);
    pbwio__msh_head(w, dim, 1, 0, w->point_count, 4);
    for (i = 1; i <= w->point_count; i++) {
        pbwio__int(w, (long long)i, 8);
        pbwio__end_line(w);
    }
    pbwio__points(w, "", -1, 3, 0);
    pbwio__print(w, "%s$EndNodes\n$Elements\n", w->text ? "" : "\n");
    pbwio__msh_head(w, blocks, facets + w->cell_count, 1, facets + w->cell_count, 8);
    if (facets != 0) {
        pbwio__msh_head(w, dim - 1, 1, facet_type, facets, 4);
        pbwio__cells(w, 1, "", 1, 1, -1);
    }
    pbwio__msh_head(w, dim, 1, type, w->cell_count, 4);
    pbwio__cells(w, 0, "", (long long)facets + 1, 1, -1);
    pbwio__print(w, "%s$EndElements\n", w->text ? "" : "\n");
}

/* Medit: the number that ends a line is a reference, 0 for points, 1 for the hull and for the simplices. */
static void pbwio__write_mesh(pbwio__writer *w)
{
    int dim = w->mesh->dim;
    size_t i, k, d = (size_t)dim;
    pbwio__print(w, "MeshVersionFormatted 2\nDimension %d\nVertices\n%zu\n", dim, w->point_count);
    for (i = 0; i < w->mesh->point_count; i++) {
        if (w->number == NULL || w->number[i] != PBW_NONE) {
            for (k = 0; k < d; k++) {
                pbwio__real(w, w->mesh->points[d * i + k]);
            }
            pbwio__print(w, "0\n");
        }
    }
    if (w->facet_count != 0) {
        pbwio__print(w, "%s\n%zu\n", dim == 3 ? "Triangles" : "Edges", w->facet_count);
        pbwio__cells(w, 1, "", -1, 1, 1);
    }
    pbwio__print(w, "%s\n%zu\n", dim == 3 ? "Tetrahedra" : "Triangles", w->cell_count);
    pbwio__cells(w, 0, "", -1, 1, 1);
    pbwio__print(w, "End\n");
}

/* Neighbours keep the order of the corners that they are across from; -1 is the hull. */
static void pbwio__write_neigh(pbwio__writer *w)
{
    size_t i, k, n = 0;
    pbwio__print(w, "%zu %zu\n", w->cell_count, w->corners);
    for (i = 0; i < w->mesh->simplex_count; i++) {
        if (pbwio__kept(w, i)) {
            pbwio__int(w, (long long)n++, 8);
            for (k = 0; k < w->corners; k++) {
                pbw_index other = w->mesh->neighbors[w->corners * i + k];
                int none = pbwio__on_hull(w, i, k);
                pbwio__int(w, none ? -1 : (long long)(w->number == NULL ? other : w->number[other]), 8);
            }
            pbwio__end_line(w);
        }
    }
}

static void pbwio__write_ply(pbwio__writer *w, int facets)
{
    pbwio__print(w, "ply\nformat %s 1.0\n",
                 w->text ? "ascii" : pbwio__little_endian() ? "binary_little_endian" : "binary_big_endian");
    pbwio__print(w, "element vertex %zu\nproperty double x\nproperty double y\nproperty double z\n", w->point_count);
    pbwio__print(w, "element face %zu\nproperty list uchar int vertex_indices\nend_header\n",
                 facets ? w->facet_count : w->cell_count);
    pbwio__points(w, "", -1, 3, 0);
    pbwio__cells(w, facets, w->text ? "3 " : "\3", -1, 0, -1);
}

static void pbwio__write_stl(pbwio__writer *w, int facets)
{
    size_t i, j, dim = (size_t)w->mesh->dim, simplex = 0, k = (size_t)-1;
    char head[80] = "triangles";
    pbw_index corner[4];
    if (w->text) {
        pbwio__print(w, "solid triangles\n");
    } else {
        pbwio__put(w, head, sizeof head);
        pbwio__int(w, (long long)(facets ? w->facet_count : w->cell_count), 4);
    }
    while (pbwio__step(w, facets, &simplex, &k)) {
        double row[4][3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } }, a[3], b[3], size;
        pbwio__corners(w, simplex, k, corner);
        for (i = 0; i < 3; i++) {
            for (j = 0; j < dim; j++) {
                row[i + 1][j] = w->mesh->points[dim * corner[i] + j];
            }
        }
        for (j = 0; j < 3; j++) {
            a[j] = row[2][j] - row[1][j];
            b[j] = row[3][j] - row[1][j];
        }
        for (j = 0; j < 3; j++) {
            row[0][j] = a[(j + 1) % 3] * b[(j + 2) % 3] - a[(j + 2) % 3] * b[(j + 1) % 3];
        }
        size = sqrt(row[0][0] * row[0][0] + row[0][1] * row[0][1] + row[0][2] * row[0][2]);
        for (i = 0; i < 4; i++) {
            pbwio__print(w, "%s", !w->text ? "" : i == 0 ? "facet normal " : "vertex ");
            for (j = 0; j < 3; j++) {
                float x = (float)(i > 0 ? row[i][j] : size > 0 ? row[0][j] / size : 0);
                if (w->text) {
                    pbwio__real(w, i == 0 ? (double)x : row[i][j]);
                } else {
                    pbwio__put(w, &x, sizeof x);
                }
            }
            pbwio__end_line(w);
            pbwio__print(w, "%s", !w->text ? "" : i == 0 ? "outer loop\n" : i == 3 ? "endloop\nendfacet\n" : "");
        }
        pbwio__put(w, "\0", w->text ? 0 : 2);
    }
    pbwio__print(w, "%s", w->text ? "endsolid triangles\n" : "");
}

PBWIODEF pbwio_status pbwio_save(const char *path, void (*emit)(void *user, FILE *file), void *user,
                                 pbwio_error *error)
{
    static const char ending[] = ".part";
    pbwio_status status = PBWIO_OK;
    size_t length = path == NULL ? 0 : strlen(path);
    int in_place = length > 5 && memcmp(path, "/dev/", 5) == 0, failed;
    char *name;
    FILE *file;
    if (path == NULL || emit == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, "pbwio_save", "an argument is NULL");
    }
    name = (char *)PBWIO_REALLOC(NULL, length + sizeof ending);
    if (name == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_MEMORY, path, "out of memory");
    }
    strcpy(name, path);
    strcat(name, in_place ? "" : ending);
    errno = 0;
    file = fopen(name, "wb");
    if (file == NULL) {
        status = pbwio__file_error(error, PBWIO_ERROR_FILE, path, "%s", strerror(errno));
    } else {
        emit(user, file);
        failed = ferror(file) | fflush(file);
        failed |= fclose(file);
#ifdef _WIN32
        if (!failed && !in_place) {
            remove(path);                                            /* rename does not replace there */
        }
#endif
        if (failed || (!in_place && rename(name, path) != 0)) {
            status = pbwio__file_error(error, PBWIO_ERROR_FILE, path, "%s",
                                       errno == 0 ? "cannot write" : strerror(errno));
            if (!in_place) {
                remove(name);
            }
        }
    }
    PBWIO_FREE(name);
    return status;
}

static void pbwio__emit(void *user, FILE *file)
{
    pbwio__writer *w = (pbwio__writer *)user;
    size_t dim = (size_t)w->mesh->dim;
    int facets = dim == 3;
    w->file = file;
    switch (w->format) {
        case PBWIO_VTU: pbwio__write_vtu(w); break;
        case PBWIO_MSH: pbwio__write_msh(w); break;
        case PBWIO_MESH: pbwio__write_mesh(w); break;
        case PBWIO_NEIGH: pbwio__write_neigh(w); break;
        case PBWIO_PLY: pbwio__write_ply(w, facets); break;
        case PBWIO_STL: pbwio__write_stl(w, facets); break;
        case PBWIO_NODE:
            pbwio__print(w, "%zu %zu %d 0\n", w->point_count, dim, w->mesh->weights != NULL);
            pbwio__points(w, "", 0, dim, 1);
            break;
        case PBWIO_ELE:
            pbwio__print(w, "%zu %zu 0\n", w->cell_count, w->corners);
            pbwio__cells(w, 0, "", 0, 0, -1);
            break;
        case PBWIO_OBJ:
            pbwio__points(w, "v ", -1, 3, 0);
            pbwio__cells(w, facets, "f ", -1, 1, -1);
            break;
        case PBWIO_CSV:
            pbwio__print(w, "x,y%s%s\n", dim == 3 ? ",z" : "", w->mesh->weights != NULL ? ",weight" : "");
            w->between = ',';
            /* fall through */
        default: pbwio__points(w, "", -1, dim, 1);
    }
    pbwio__flush(w);
}

PBWIODEF pbwio_status pbwio_write(const char *path, const pbw_mesh *mesh, const pbwio_output *output,
                                  pbwio_error *error)
{
    static const pbwio_output defaults = { PBWIO_AUTO, 0, NULL, NULL, NULL };
    size_t i, k;
    int surface, failed = 0;
    pbwio_format format;
    pbwio_status status;
    pbwio__writer *w;
    if (path == NULL || mesh == NULL || (mesh->dim != 2 && mesh->dim != 3)) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, "pbwio_write", "no path or no mesh");
    }
    output = output == NULL ? &defaults : output;
    format = output->format != PBWIO_AUTO ? output->format : pbwio_format_of(path);
    surface = format == PBWIO_OBJ || format == PBWIO_PLY || format == PBWIO_STL;
    if (format == PBWIO_AUTO || format == PBWIO_OFF) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, path, "no format of that name is written");
    }
    if (mesh->neighbors == NULL && mesh->simplex_count > 0
        && (format == PBWIO_NEIGH || (surface && mesh->dim == 3))) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, path, "this format needs neighbors, the mesh has none");
    }
    w = (pbwio__writer *)PBWIO_REALLOC(NULL, sizeof *w);
    if (w == NULL) {
        return pbwio__file_error(error, PBWIO_ERROR_MEMORY, path, "out of memory");
    }
    memset(w, 0, sizeof *w);
    w->mesh = mesh;
    w->output = output;
    w->format = format;
    w->between = ' ';
    w->id_size = format == PBWIO_MSH ? 8 : 4;
    w->corners = (size_t)mesh->dim + 1;
    w->text = (output->flags & PBWIO_TEXT) != 0
           || !(format == PBWIO_VTU || format == PBWIO_MSH || format == PBWIO_PLY
                || (format == PBWIO_STL && pbwio__little_endian()));         /* STL has no other byte order */
    if (format == PBWIO_NEIGH && output->keep != NULL) {
        w->number = (pbw_index *)PBWIO_REALLOC(NULL, (mesh->simplex_count + 1) * sizeof *w->number);
        failed = w->number == NULL;
    } else if (format != PBWIO_NEIGH) {
        failed = !pbwio__number_points(w, !surface && !(output->flags & PBWIO_NO_ORPHANS), surface && mesh->dim == 3);
    }
    for (i = 0; i < mesh->simplex_count && !failed; i++) {
        if (format == PBWIO_NEIGH && w->number != NULL) {
            w->number[i] = (pbw_index)w->cell_count;
        }
        if (pbwio__kept(w, i)) {
            w->cell_count++;
            for (k = 0; k < w->corners && mesh->neighbors != NULL; k++) {
                w->facet_count += (size_t)pbwio__on_hull(w, i, k);
            }
        }
    }
    status = failed ? pbwio__file_error(error, PBWIO_ERROR_MEMORY, path, "out of memory")
                    : pbwio_save(path, pbwio__emit, w, error);
    PBWIO_FREE(w->number);
    PBWIO_FREE(w);
    return status;
}

#endif /* PBW_IO_IMPLEMENTATION */
