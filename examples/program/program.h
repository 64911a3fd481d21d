/* program.h: what the files of the pbw program share.

   A command is one file, which defines a `const command command_NAME`, and one line in COMMANDS below; its help, the
   list of commands and the search for misspelt names follow from that. */
#ifndef PROGRAM_H
#define PROGRAM_H

#ifndef _FILE_OFFSET_BITS
#define _FILE_OFFSET_BITS 64                         /* files beyond 2 GB where a long has 32 bits */
#endif
#ifndef _LARGEFILE_SOURCE
#define _LARGEFILE_SOURCE 1
#endif
#include "pbw.h"
#include "pbw_adapt2.h"
#include "pbw_adapt3.h"
#include "pbw_cells.h"
#include "pbw_check.h"
#include "pbw_fill.h"
#include "pbw_improve.h"
#include "pbw_io.h"
#include "pbw_live.h"
#include "pbw_mesh2.h"
#include "pbw_mesh3.h"
#include "pbw_model.h"
#include "pbw_picture.h"
#include "pbw_query.h"
#include "pbw_sample.h"
#include "pbw_surface.h"
#include "pbw_view.h"
#include "pbw_wrap.h"
#include <float.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define COMMANDS(X) X(mesh) X(sample) X(check) X(convert) X(bench) X(view) X(locate) X(nearest) X(cells) X(plane) \
    X(improve) X(solid) X(fill) X(wrap) X(tiles) X(hash) X(live)

#if defined(__GNUC__)
#define PRINTF(a, b) __attribute__((format(printf, a, b)))
#else
#define PRINTF(a, b)
#endif

enum { MOST_OUTPUTS = 32, FAILURE = 1, USAGE = 2, MOST_SHOWN = 10 };

/* ---- options ---- */

/* What the value of an option is. */
typedef enum value_kind {
    SWITCH,                                          /* none */
    PLAIN,
    WHOLE, POSITIVE,                                 /* a number from least to most; above 0, to most if that is */
    FORMULA,                                         /* a number above 0, or something else */
    BYTES,                                           /* bytes, with K, M, GiB, GB ... */
    DIRECTION, PLANE,                                /* X,Y,Z; A,B,C,D with D from -1 to 1; not 0,0,0 */
    CHOICE,                                          /* one of choices */
    BOX,                                             /* low corner, high corner: 4 or 6 numbers */
    LATTICE,                                         /* vectors: 4 or 9 numbers */
    AXES,                                            /* some of the letters x, y, z */
    GENERATE,                                        /* one of choices, and a count in the next argument */
    OUTPUT                                           /* a file; it may come several times */
} value_kind;

typedef struct option {
    const char *name, *value, *help;                 /* "--count", "N", lines for --help */
    value_kind kind;
    double least, most;
    const char *const *choices;                      /* NULL ends them */
} option;

/* Groups of options that commands share; an option without a name ends each. */
extern const option input_options[], weight_options[], build_options[], inside_options[], look_options[],
                    output_options[], text_options[], common_options[], file_mesh_options[];

/* Options that several commands have in groups of their own; each is defined here alone.  Where the meaning depends
   on the command, the help is an argument. */
extern const char *const smoothers[];                /* laplace, lloyd, odt */
#define OPTION_ALPHA(help, kind) { "--alpha", "R", help, kind, 0, 0, NULL }
#define OPTION_CONFORMING(help) { "--conforming", NULL, help, SWITCH, 0, 0, NULL }
#define OPTION_COUNT(help) { "--count", "N", help, WHOLE, 1, 4e9, NULL }
#define OPTION_FEATURE_ANGLE { "--feature-angle", "DEGREES", \
    "edges of the surface that bend by more are sharp, and stay; default 40", WHOLE, 1, 180, NULL }
#define OPTION_GRADATION(help) { "--gradation", "G", help, POSITIVE, 0, 0, NULL }
#define OPTION_MOST(simplices) { "--most", "N", \
    simplices "; more are refused, before work if sizes ask for them; default 50 million", POSITIVE, 0, 0, NULL }
#define OPTION_NESTED(more) { "--nested", NULL, \
    "shells inside of others bound regions; default: every second one is a cavity" more, SWITCH, 0, 0, NULL }
#define OPTION_NO_CHECK { "--no-check", NULL, "skip the exact check of the result", SWITCH, 0, 0, NULL }
#define OPTION_NO_ORPHANS { "--no-orphans", NULL, \
    "leave points that are corners of nothing out of the output", SWITCH, 0, 0, NULL }
#define OPTION_QUALITY { "--quality", NULL, \
    "print measures of quality, by the names of Verdict and Gmsh", SWITCH, 0, 0, NULL }
#define OPTION_ROUNDS(help) { "--rounds", "N", help, WHOLE, 1, 1000, NULL }
#define OPTION_SECONDS { "--seconds", "S", \
    "of all threads' processor time, then it ends with what it has", POSITIVE, 0, 0, NULL }
#define OPTION_SEED { "--seed", "S", "of random numbers, up to 1000000; default 1", WHOLE, 0, 1e6, NULL }
#define OPTION_SIZE(bound) { "--size", "SIZE", \
    "length of edges, " bound ": a number, or a formula in x, y (and z) such as\n\"0.1+0.2*hypot(x,y)\", with " \
    "+ - * / ^ sqrt abs exp log sin cos min max hypot, or a\ncolumn with the size at each point, by its name or " \
    "as #4", FORMULA, 0, 0, NULL }
#define OPTION_SMOOTH(help) { "--smooth", "WAY", help, CHOICE, 0, 0, smoothers }
#define OPTION_TARGET(more) { "--target", "DEGREES", \
    "dihedral angles from this to 180 less this" more, WHOLE, 1, 60, NULL }

/* ---- commands ---- */

typedef struct job job;

typedef struct command {
    const char *name, *summary;                      /* summary: for the list of commands */
    const char *usage;                               /* what its --help says before the options */
    const char *writes;                              /* endings of its outputs with blanks between; NULL: none */
    const option *options[10];                       /* groups; NULL ends them */
    int (*run)(job *j);                              /* returns the exit status */
    int may_lack_input;
    int outputs_follow;                              /* arguments after the input are outputs */
    int names_output;                                /* without an output: the input's name with its only ending */
    const char *second;                              /* what the second input is: "queries"; NULL: none */
    int may_be_flat;                                 /* points that span no simplex will do */
} command;

#define DECLARE(name) extern const command command_##name;
COMMANDS(DECLARE)
#undef DECLARE

typedef struct given { const option *option; const char *value, *more; } given;

struct job {
    const command *command;
    const char *input, *output[MOST_OUTPUTS];        /* input: NULL if points are generated */
    const char *second;                              /* the second input */
    char named[1024];                                /* the output that the program names */
    char points[1024];                               /* the .node file beside an .ele file */
    int outputs, written;                            /* how many are named, how many of them are there */
    given *given;                                    /* options, in their order */
    int given_count;
    int terminal, quiet;
    const char *stage;                               /* of PBW_STAGE_WORK; NULL: the name of the command */
    FILE *report;                                    /* standard output, unless an output goes there */
    const char *generate;                            /* kind of points, NULL = they are read */
    size_t count;                                    /* how many of them */
    pbwio_options read;                              /* filled from the options */
    pbwio_output write;
    pbwpic_options picture;
    pbw_options build;
    pbwio_cloud cloud, surface, queries;             /* what is read and made; surface: of --surface */
    pbw_mesh mesh;
    int open_surface;                                /* --inside is of a surface with open edges, turned alike */
    unsigned char *inside;                           /* per simplex: is its centre in the surface, is it to be kept?
                                                        NULL: not known */
    pbw_index *links;                                /* neighbors of a mesh that a file has; NULL: none */
    pbw_index *patches;                              /* one a corner of a mesh that a file has: the facet's group */
    double *over;                                    /* of a surface for a page: x, y of its points, then z */
};

/* ---- options.c ---- */

/* Fills the job; returns 0, or the exit status plus one. */
int parse(int argc, char **argv, job *j);
int is_given(const job *j, const char *name);
const char *text_of(const job *j, const char *name);                  /* NULL: it is not given */
double number_of(const job *j, const char *name, double otherwise);
int choice_of(const job *j, const char *name);                        /* its number in choices; -1: it is not given */
/* Returns whether it is given as so many numbers; leaves out as it is if not given. */
int vector_of(const job *j, const char *name, int count, double *out);
PRINTF(1, 2) int complain(const char *format, ...);                   /* prints; returns USAGE */

/* The best of the names that were considered, if it is near enough to be meant. */
typedef struct nearest { const char *word, *name; int distance; } nearest;
void suggest(nearest *n, const char *name);

void print_help(const command *c, int all);

/* ---- manual.c: what is made of the tables of commands and options ---- */

enum { EXAMPLES = 2 };
const char *example_of(const command *c, int i);                     /* the i-th example at the end of its help */
/* Prints the manual page, or completions for a shell: kind is --man, --bash or --zsh; returns 0 for others. */
int print_manual(const char *kind, const command *const *commands);

/* ---- effects.c ---- */

/* Refuses options that would have no effect, or exclude each other; after check_outputs.  Returns 0 or USAGE. */
int check_effects(const job *j);

/* ---- terminal.c ---- */

extern volatile sig_atomic_t interrupted;
void catch_interrupt(void);
double now(void);
void start_clock(const job *j);                      /* on a terminal, shows how long work is silent */
int draw_bar(const job *j, const char *name, double done);            /* returns whether the work must stop */
void begin(const job *j, const char *name, const char *what);         /* a stage that cannot tell how far it is */
PRINTF(2, 3) int fail(const job *j, const char *format, ...);         /* prints; returns FAILURE */
int stopped(const job *j);                                            /* the same after an interrupt */
PRINTF(2, 3) void warn(const job *j, const char *format, ...);
/* A line of the report, with and without a time. */
PRINTF(4, 5) void report_step(const job *j, const char *what, double seconds, const char *format, ...);
PRINTF(2, 3) void report_line(const job *j, const char *format, ...);
const char *plural(size_t count);                                     /* "" for 1, else "s" */
#define COUNT(n) (size_t)(n), plural((size_t)(n))                     /* for "%zu point%s" */

/* ---- steps.c: steps of commands; each returns 0 or the exit status ---- */

int load(job *j, int flat);                                          /* flat: without z if all have the same */
int load_surface(job *j);                                             /* for --inside, before the work */
int load_queries(job *j);                                            /* in the dimension of the points */
void warn_of_heights(const job *j, size_t differ);                   /* of so many points that coincide with others */
int build(job *j);
int check(job *j);
/* "tetrahedra" or "triangles", "simplices" of no dimension; of one the singular. */
const char *simplices(int dim, size_t count);
void describe(const job *j);
int mark_inside(job *j);
/* Says why the library failed; the exit status, 0 for PBW_OK. */
int explain(const job *j, pbw_status status);
int explain_io(const job *j, pbwio_status status, const pbwio_error *error);     /* of reading and writing */
int explain_file(const job *j, pbw_status status, const char *why);  /* of the input; why: in words, "" = none */
pbwsample_model model_of(const pbwio_cloud *cloud);

/* ---- gpu.c ---- */

/* Makes volumes, centroids and facets of the job's points in the domain's box, which may repeat, or in the whole
   space.  Returns 0 or the exit status: also without CUDA in the program, or without a GPU.  For gpu_free, not for
   pbw_cells_free. */
int gpu_cells(job *j, const pbw_domain *domain, pbw_cells *cells);
void gpu_free(pbw_cells *cells);

/* ---- filemesh.c: simplices that a file has; each returns 0 or the exit status ---- */

typedef struct mesh_fault { size_t count, first; } mesh_fault;       /* first: the number of a simplex */
typedef struct mesh_faults {
    mesh_fault turned, flat, crowded, folded;        /* negative; without volume; facets of more than two simplices,
                                                        of two on one side */
    size_t boundary;                                 /* facets of one simplex */
} mesh_faults;

int has_simplices(const job *j);                                     /* tetrahedra, or triangles of the plane */
/* j->mesh becomes the simplices of the file, all turned positive; it borrows the cloud's arrays. */
int take_simplices(job *j, mesh_faults *faults);
int check_simplices(job *j);                                         /* takes them, reports faults and quality */
/* Returns the facets of j->mesh without a neighbor, turned outward, three points each; the caller frees them.  NULL:
   no memory. */
pbw_index *boundary_of(const job *j, size_t *count);

/* ---- output.c ---- */

/* Elements without points are of no use: adds an output .node beside the first .ele where none is named. */
int add_points(job *j);
int check_outputs(const job *j);                                      /* before the work; each returns 0 or USAGE */
const char *ending_of(const job *j, const char *path);                /* of what the command writes; NULL: none */
int writes_pages(const job *j);
pbwio_status write_mesh_page(const job *j, const char *path, pbwio_error *error);
int write_mesh(job *j);
int write_model(job *j, pbwmodel_content *content);
/* Writes each output by a function that gets its path, its ending and user. */
typedef pbwio_status writer(job *j, const char *path, const char *ending, void *user, pbwio_error *error);
int write_with(job *j, writer *write, void *user);
int write_table(job *j, void (*emit)(void *user, FILE *file), void *user);       /* the same text to each output */

/* ---- groups.c: groups of elements of the input; each returns 0 or the exit status ---- */

/* Where some elements of the cloud are in groups, all have a group, PBW_NONE if they are in none. */
int complete_groups(job *j);
/* The same of a surface in space.  Fails if it has no faces; warns of tetrahedra, which do not come out. */
int complete_faces(job *j);
/* Fills j->patches, one a corner: the group of the triangle, in the plane of the segment, across from it. */
int find_patches(job *j, const pbw_index *simplices, size_t count);
/* The outputs have the groups of the input's elements; j->mesh is of its simplices. */
int keep_groups(job *j);
void drop_groups(job *j);                                             /* the outputs have no groups, and no edges */

/* ---- view.c, convert.c: faces in space ---- */

/* j->mesh becomes the faces of the cloud, a mesh of x and y with heights; it borrows: nothing in it is pbw_free's. */
int show_faces(job *j);
/* Fills in what is written of points and faces: groups and columns of the input. */
void fill_surface(const job *j, pbwmodel_content *content, pbwio_output *output);

/* ---- diagram.c ---- */

/* Cells with shapes as .obj, .vtu, .svg, .geojson; without what is unbounded. */
pbwio_status write_diagram(const char *path, const char *ending, const pbw_cells *cells, pbwio_error *error);

int is_drawn(const pbw_cells *cells, size_t i);                      /* is cell i bounded and not empty? */
/* The end of what begins with facet f of cell i: of a polyhedron that facet, in the plane the loop. */
size_t loop_end(const pbw_cells *cells, size_t i, size_t f);

/* ---- features.c: GeoJSON, one feature for each triangle or cell of the plane ---- */

pbwio_status write_triangles(const char *path, const pbw_mesh *mesh, const pbwio_output *output, pbwio_error *error);
/* room: so many bytes as cell_features_room says. */
void emit_cell_features(const pbw_cells *cells, FILE *file, void *room);
size_t cell_features_room(const pbw_cells *cells);

/* ---- cellpage.c ---- */

/* Writes a page of the bounded ones of cells with shapes.  in_polygon: they are in the plane, and may have notches,
   holes and several parts. */
pbwio_status write_cell_page(job *j, const char *path, const pbw_cells *cells, int in_polygon, pbwio_error *error);

/* ---- plane.c ---- */

void describe_plane_measures(const job *j, const pbw_plane *plane);  /* --quality */

/* ---- expression.c ---- */

/* The value of a formula at x, y and in 3D z; *wrong: where it is none, else NULL. */
double evaluate(const char *formula, int dim, const double *at, const char **wrong);

/* ---- sizes.c: --size; each returns 0 or the exit status ---- */

const char *size_column(const char *size);           /* the column that it names: no formula, but a word, or # and a
                                                        number; NULL: none */
int check_sizes(const job *j, const char *name, int dim);      /* refuses what is neither */
int load_sizes(job *j, const char *name, int flat);  /* as load(); weights of the cloud are the column's values */
double size_at_point(const job *j, size_t point);    /* after load_sizes, in 3D; 1 without --size */

typedef struct sizing {                              /* sizes in space */
    const char *formula;                             /* NULL: of values */
    const double *values;                            /* one a point of the surface */
    pbw_surface surface;
    pbw_index *corners;                              /* of the surface where the model has no faces; else NULL */
    double least, most;
} sizing;
int set_sizes(job *j, sizing *s, pbw_solid_options *how);            /* of the surface that load_sizes has read */
int set_alphas(job *j, sizing *s, pbw_wrap_options *how);            /* alpha; of no number the offset, too */
void free_sizes(sizing *s);

/* ---- carry.c ---- */

/* Gives each point the value of the first one at its place; returns how many had another. */
size_t unify(const pbw_index *first, size_t count, double *values);

/* ---- improve.c ---- */

void describe_quality(const job *j, const char *when, const pbw_quality *q);
void describe_histogram(const job *j, const pbw_quality *q);
void describe_mesh_quality(const job *j);                            /* angles of j->mesh */
void describe_measures(const job *j, const pbw_tets *tets);          /* --quality */
void show_tets(job *j, const pbw_tets *tets);                       /* j->mesh becomes their view, not to be freed */

/* ---- pbwt.c: files of tiles; each returns the exit status ---- */

int is_pbwt(const job *j);                                           /* is the input one, by its name? */
int check_pbwt(job *j);
int convert_pbwt(job *j, pbw_mesh *mesh);                          /* the tile of --tile; pbwtf_mesh_free when done */

/* ---- wrap.c ---- */

extern const option wrapping_options[];
int wrap_solid(job *j);                              /* pbw solid --wrap */

/* ---- surface.c ---- */

/* Reports the parts of a surface, and the faults of its edges; details: where they are.  Returns whether it has an
   inside. */
int describe_surface(job *j, const pbwio_cloud *cloud, int details);
/* The same where its faults are known; start: when the work began. */
int describe_faults(job *j, const pbwio_cloud *cloud, const pbw_surface_faults *faults, int details, double start);

/* ---- faults.c ---- */

int check_faces(job *j);                                              /* reports and writes the faults of a surface */

#endif
