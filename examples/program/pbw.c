/* pbw.c: samples models, triangulates points, checks, writes, shows and measures.
   cc -O2 -I. -Iexamples/lib examples/program/pbw.c -o pbw -lpthread -lm
   ./pbw model.obj -o model.vtu -o model.html;  ./pbw --help lists the commands. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_IO_IMPLEMENTATION
#include "pbw_io.h"
#define PBW_MODEL_IMPLEMENTATION
#include "pbw_model.h"
#define PBW_PICTURE_IMPLEMENTATION
#include "pbw_picture.h"
#define PBW_SAMPLE_IMPLEMENTATION
#include "pbw_sample.h"
#define PBW_VIEW_IMPLEMENTATION
#include "pbw_view.h"
#include "pbw_generate.h"
#include <signal.h>
#ifdef _WIN32
#include <io.h>
#define isatty _isatty
#else
#include <sys/time.h>
#include <unistd.h>
#endif

enum { MOST_OUTPUTS = 32, FAILURE = 1, USAGE = 2 };

/* ---- the commands and their options ---- */

enum { MESH = 1, SAMPLE = 2, CHECK = 4, CONVERT = 8, BENCH = 16, VIEW = 32, ALL = 63, SHOWN = MESH | VIEW };

static const char *const help[] = {
    "usage: pbw [mesh] [options] input [-o output]...\n"
    "\n"
    "Exact Delaunay triangulation of the points of a file, or with --weights the regular one.\n"
    "\n"
    "input:   .obj .ply .stl .off .node, tables (.xyz .csv .txt ...); - is the standard input\n"
    "output:  .vtu .msh .msh2 .mesh .inp .su2 .node .ele .neigh .face .edge (simplices, boundary),\n"
    "         .obj .ply .stl .off (hull), .xyz .csv (points), .svg (picture), .html (page to look around\n"
    "         in); any number of them\n"
    "\n"
    "  --any-order           skip the canonical order of simplices\n"
    "  --no-check            skip the exact check of the result\n"
    "  --no-orphans          leave points that are corners of nothing out of the output\n",

    "usage: pbw sample [options] model -o output...\n"
    "\n"
    "Points spread evenly over the surface of a model, none closer to another than a radius, with normals.\n"
    "\n"
    "input:   .obj .ply .stl .off with faces\n"
    "output:  .ply .obj .off .xyz .csv; any number of them\n"
    "\n"
    "  --count N             that many on the surface; default 20000\n"
    "  --radius R            instead: that distance apart, as many as there is room for\n"
    "  --uniform             independent random points instead, with --count\n"
    "  --fill lattice|poisson    add points inside, as far apart: a jittered lattice or blue noise\n"
    "  --thin                sides of a sheet thinner than the radius do not keep points apart\n"
    "  --facet-normals       normals of the faces, not interpolated ones\n",

    "usage: pbw check [options] input\n"
    "\n"
    "Tells what is wrong with a model's surface, and proves the triangulation of its points.\n"
    "The exit status is 1 if edges are open, crowded or turned, or the triangulation is wrong.\n"
    "\n",

    "usage: pbw convert [options] input output...\n"
    "\n"
    "Points, normals and faces from one format to another.\n"
    "\n"
    "input:   as for pbw mesh\n"
    "output:  .obj .ply .off .stl with faces, .xyz .csv without\n"
    "\n",

    "usage: pbw bench [options] [input]\n"
    "\n"
    "Times of the triangulation by number of threads, best of three; default: --generate uniform 1000000.\n"
    "\n",

    "usage: pbw view [options] input [-o page.html]\n"
    "\n"
    "Makes a page to look at the triangulation of the points of a file in a browser: one file, no network.\n"
    "\n"
    "input:   as for pbw mesh\n"
    "output:  .html; default: the name of the input with that ending\n"
    "\n"
    "  --points              the points, not triangulated\n"
};

static const struct { const char *text; unsigned commands; } shared_help[] = {
    { "  --inside              only what is inside the surface of the model\n"
      "  --surface MODEL       the model for --inside, if it is not the input\n"
      "  --title TEXT          pages: default: the name of the input\n"
      "  --colour NAME         pages: what the colours show at first: quality, part (of the curve, as many as\n"
      "                        threads), thread (in whose share a point was) and round (that inserted it),\n"
      "                        order (of the points in the input), weight, z\n"
      "  --eye X,Y,Z           pictures and pages: direction to the viewer\n"
      "  --up X,Y,Z            pictures and pages: upwards; default 0,0,1\n"
      "  --cut A,B,C,D         pictures and pages: cut away Ax+By+Cz > D, D from -1 to 1; D = 1 cuts nothing\n"
      "  --cut-through         pages: cut simplices through instead of leaving them out\n"
      "  --colour-outside      pages: colours on the outside too, not only where it is cut\n", SHOWN },
    { "  --dim 2|3             dimension; default 3, or 2 for files of two columns or of one z\n", ALL & ~SAMPLE },
    { "  --columns X,Y[,Z]     which columns, by number from 1 or by name\n", ALL & ~SAMPLE },
    { "  --weights COLUMN      regular triangulation with the weights of that column\n",
      SHOWN | CHECK | BENCH },
    { "  --generate KIND N     N points instead of an input: uniform gauss ball sphere lattice clusters lines\n"
      "                        spiral plane anisotropic moment\n", ALL & ~SAMPLE },
    { "  --seed S              of random numbers, up to 1000000; default 1\n", ALL },
    { "  --threads N           default: all cores\n", SHOWN | CHECK | BENCH },
    { "  --memory-limit SIZE   such as 500M or 4G: fail rather than use more for the triangulation\n",
      SHOWN | CHECK | BENCH },
    { "  --text                text instead of binary output\n", MESH | SAMPLE | CONVERT },
    { "  --quiet               print errors only\n", ALL }
};

static const char *const commands[] = { "mesh", "sample", "check", "convert", "bench", "view", NULL };
static const char *const command_help[] = {
    "triangulate points; also without its name", "spread points over a model",
    "find faults in a model and its triangulation", "from one format to another", "measure",
    "make a page to look at"
};

enum { QUIET, NO_CHECK, ANY_ORDER, INSIDE, NO_ORPHANS, TEXT, UNIFORM, THIN, FACET_NORMALS, POINTS,
       CUT_THROUGH, COLOUR_OUTSIDE, SWITCHES };
static const char *const switches[] = { "--quiet", "--no-check", "--any-order", "--inside", "--no-orphans", "--text",
                                        "--uniform", "--thin", "--facet-normals", "--points", "--cut-through",
                                        "--colour-outside", NULL };
static const unsigned switch_commands[] = { ALL, MESH, MESH, SHOWN, MESH, MESH | SAMPLE | CONVERT,
                                            SAMPLE, SAMPLE, SAMPLE, VIEW, SHOWN, SHOWN };

enum { O, DIM, COLUMNS, WEIGHTS, THREADS, MEMORY_LIMIT, SEED, EYE, UP, CUT, GENERATE, COUNT, RADIUS, FILL, SURFACE,
       TITLE, COLOUR };
static const char *const settings[] = { "-o", "--dim", "--columns", "--weights", "--threads", "--memory-limit",
                                        "--seed", "--eye", "--up", "--cut", "--generate", "--count", "--radius",
                                        "--fill", "--surface", "--title", "--colour", NULL };
static const unsigned setting_commands[] = {
    SHOWN | SAMPLE | CONVERT, ALL & ~SAMPLE, ALL & ~SAMPLE, SHOWN | CHECK | BENCH,
    SHOWN | CHECK | BENCH, SHOWN | CHECK | BENCH, ALL, SHOWN, SHOWN, SHOWN, ALL & ~SAMPLE, SAMPLE, SAMPLE,
    SAMPLE, SHOWN, SHOWN, SHOWN
};

static const char *const fills[] = { "lattice", "poisson", NULL };

typedef struct job {
    unsigned command;                                /* one of the bits above */
    const char *input, *output[MOST_OUTPUTS], *generate, *surface, *title, *colour;
    char page[1024];                                 /* the output of view, if none is named */
    int outputs, kind, fill, terminal, on[SWITCHES];
    size_t count;                                    /* of --generate */
    pbwio_options read;
    pbwio_output write;
    pbwpic_options picture;
    pbw_options build;
    pbwsample_options sample;
    pbwio_cloud cloud, normals, surface_cloud;       /* what is read and made */
    pbwsample_set samples;
    pbw_mesh mesh;
} job;

static int complain(const char *what, const char *detail)
{
    fprintf(stderr, "pbw: %s%s\n", what, detail);
    return USAGE;
}

static int numbers(const char *text, int count, double *out)         /* "1,2,3" */
{
    char *end;
    int i;
    for (i = 0; i < count; i++, text = end + 1) {
        out[i] = strtod(text, &end);
        if (end == text || !(fabs(out[i]) <= DBL_MAX) || *end != (i + 1 < count ? ',' : 0)) {
            return 0;
        }
    }
    return 1;
}

static int whole(const char *text, double least, double most, double *out)        /* with K, M or G */
{
    static const char units[] = "KMG";
    char *end, *unit;
    *out = strtod(text, &end);
    unit = *end != 0 ? strchr(units, *end) : NULL;
    if (unit != NULL) {
        *out *= (double)((size_t)1 << (10 * (unit - units + 1)));
        end++;
    }
    return end != text && *end == 0 && *out >= least && *out <= most && *out == floor(*out);
}

static int find(const char *const *names, const char *name)          /* -1: it is not there */
{
    int i;
    for (i = 0; names[i] != NULL; i++) {
        if (strcmp(names[i], name) == 0) {
            return i;
        }
    }
    return -1;
}

static int has_ending(const char *path, const char *ending)
{
    const char *dot = strrchr(path, '.');
    return dot != NULL && strcmp(dot, ending) == 0;
}

/* Whether the command can write such a file. */
static int add_output(job *j, const char *path)
{
    pbwio_format format = pbwio_format_of(path);
    j->output[j->outputs % MOST_OUTPUTS] = path;
    if (++j->outputs > MOST_OUTPUTS || j->command & (CHECK | BENCH)) {
        return 0;
    }
    if (j->command & (SAMPLE | CONVERT)) {
        return format != PBWIO_AUTO && format <= PBWIO_CSV && format != PBWIO_NODE
            && !(j->command == SAMPLE && format == PBWIO_STL);
    }
    if (j->command == VIEW) {
        return has_ending(path, ".html");
    }
    return j->command == MESH && (format != PBWIO_AUTO || has_ending(path, ".svg") || has_ending(path, ".html"));
}

/* The setting of that number; returns whether the value is proper.  more: the argument after the value or NULL. */
static int set(job *j, int setting, const char *value, const char *more)
{
    double n = 0;
    int fine = 1;
    switch (setting) {
        case O: return add_output(j, value);
        case DIM: fine = whole(value, 2, 3, &n); j->read.dim = (int)n; break;
        case COLUMNS: j->read.columns = value; break;
        case WEIGHTS: j->read.weight = value; break;
        case THREADS: fine = whole(value, 0, 256, &n); j->build.threads = (int)n; break;
        case MEMORY_LIMIT:
            fine = whole(value, 1, (double)((size_t)-1 / 2), &n);
            j->build.memory_limit = (size_t)n;
            break;
        case SEED: fine = whole(value, 0, 1e6, &n); j->sample.seed = (uint64_t)n; break;
        case EYE: return numbers(value, 3, j->picture.eye);
        case UP: return numbers(value, 3, j->picture.up);
        case CUT: return numbers(value, 4, j->picture.cut);
        case COUNT: fine = whole(value, 1, 4e9, &n); j->sample.count = (size_t)n; break;
        case RADIUS: return numbers(value, 1, &j->sample.radius) && j->sample.radius > 0;
        case FILL: j->fill = find(fills, value) + 1; return j->fill > 0;
        case SURFACE: j->surface = value; break;
        case TITLE: j->title = value; break;
        case COLOUR: j->colour = value; break;
        default:
            j->generate = value;
            j->kind = find(pbwgen_kinds, value);
            fine = j->kind >= 0 && more != NULL && whole(more, 1, 4e9, &n);
            j->count = (size_t)n;
    }
    return fine;
}

static void print_help(unsigned command, int all)
{
    size_t i, which = 0;
    while (command >> which != 1) {
        which++;
    }
    fputs(help[which], stdout);
    for (i = 0; i < sizeof shared_help / sizeof shared_help[0]; i++) {
        fputs(shared_help[i].commands & command ? shared_help[i].text : "", stdout);
    }
    puts("  --help, --version");
    for (i = 0; all && commands[i] != NULL; i++) {
        printf("%s  pbw %-8s --help   %s\n", i == 0 ? "\ncommands:\n" : "", commands[i], command_help[i]);
    }
    puts("\nexit status: 0 done, 1 failure, 2 wrong usage");
}

/* The output of view: beside the input, with another ending. */
static void name_page(job *j)
{
    const char *name = j->generate != NULL ? j->generate : strcmp(j->input, "-") == 0 ? "pbw" : j->input;
    const char *slash = strrchr(name, '/'), *dot = strrchr(name, '.');
    int length = dot != NULL && (slash == NULL || dot > slash + 1) ? (int)(dot - name) : (int)strlen(name);
    snprintf(j->page, sizeof j->page, "%.*s.html", length > 1000 ? 1000 : length, name);
    j->output[j->outputs++] = j->page;
}

/* Fills the job; returns 0, or the exit status plus one. */
static int parse(int argc, char **argv, job *j)
{
    int i = 1, k, named = argc > 1 ? find(commands, argv[1]) : -1;
    j->command = named >= 0 ? 1u << named : MESH;
    for (i += named >= 0; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) {
            print_help(j->command, named < 0);
            return 1;
        } else if (strcmp(argv[i], "--version") == 0) {
            printf("pbw %d.%d.%d\n", PBW_VERSION_MAJOR, PBW_VERSION_MINOR, PBW_VERSION_PATCH);
            return 1;
        } else if ((k = find(switches, argv[i])) >= 0 && switch_commands[k] & j->command) {
            j->on[k] = 1;
        } else if ((k = find(settings, argv[i])) >= 0 && setting_commands[k] & j->command) {
            if (i + 1 >= argc || !set(j, k, argv[i + 1], argv[i + 2 < argc ? i + 2 : argc])) {
                return 1 + complain("no proper value for ", argv[i]);
            }
            i += k == GENERATE ? 2 : 1;
        } else if (argv[i][0] == '-' && argv[i][1] != 0) {
            return 1 + complain("unknown option ", argv[i]);
        } else if (j->command == CONVERT && (j->input != NULL || j->generate != NULL)) {
            if (!add_output(j, argv[i])) {
                return 1 + complain("this format is not written: ", argv[i]);
            }
        } else if (j->input != NULL) {
            return 1 + complain("more than one input: ", argv[i]);
        } else {
            j->input = argv[i];
        }
    }
    if (j->command == BENCH && j->input == NULL && j->generate == NULL) {
        j->generate = pbwgen_kinds[0];
        j->count = 1000000;
    }
    if ((j->input == NULL) == (j->generate == NULL)) {
        return 1 + complain(j->command == SAMPLE ? "a model is needed; see pbw sample --help"
                            : "one input or --generate is needed; see --help", "");
    }
    if (j->command == VIEW && j->outputs == 0) {
        name_page(j);
    }
    if (j->command == CONVERT && j->outputs == 0) {
        return 1 + complain("an output is needed; see pbw convert --help", "");
    }
    if (j->sample.count > 0 && j->sample.radius > 0) {
        return 1 + complain("--count and --radius exclude each other", "");
    }
    if (j->on[UNIFORM] && (j->sample.radius > 0 || j->fill > 0)) {
        return 1 + complain("--uniform goes with neither --radius nor --fill", "");
    }
    j->build.flags = j->on[ANY_ORDER] ? PBW_ANY_ORDER : 0;
    j->write.flags = (j->on[NO_ORPHANS] ? PBWIO_NO_ORPHANS : 0) | (j->on[TEXT] ? PBWIO_TEXT : 0);
    return 0;
}

/* ---- the terminal ---- */

static volatile sig_atomic_t interrupted;

static void on_interrupt(int number)                 /* the first stops the work, a second one the program */
{
    interrupted = 1;
    signal(number, SIG_DFL);
}

static double now(void)
{
#ifdef _WIN32
    return (double)GetTickCount64() * 1e-3;
#else
    struct timeval time;
    gettimeofday(&time, NULL);
    return (double)time.tv_sec + 1e-6 * (double)time.tv_usec;
#endif
}

/* A bar on the terminal, if there is one. */
static int draw_bar(const job *j, const char *name, double done)
{
    int length = (int)(40 * done);
    if (j->terminal) {
        fprintf(stderr, "\r%-6s [%.*s%*s] %3.0f %%", name, length, "########################################",
                40 - length, "", 100 * done);
    }
    return interrupted;
}

static int on_progress(void *user, pbw_stage stage, double done)
{
    static const char *const names[] = { "order", "build", "output", "check" };
    return draw_bar((const job *)user, names[stage], done);
}

static int on_sampled(void *user, double done)
{
    return draw_bar((const job *)user, "sample", done);
}

static int fail(const job *j, const char *what)
{
    fflush(stdout);
    fprintf(stderr, "%spbw: %s\n", j->terminal ? "\r\033[K" : "", what);       /* in place of the bar */
    return FAILURE;
}

/* A line of the report. */
static void say(const job *j, const char *what, double seconds, const char *more)
{
    fputs(j->terminal ? "\r\033[K" : "", stderr);
    if (!j->on[QUIET]) {
        printf("%-9s %8.3f s%s%s\n", what, seconds, *more != 0 ? "   " : "", more);
        fflush(stdout);
    }
}

/* ---- steps; each returns 0 or the exit status ---- */

/* Leaves z out if all points have the same. */
static void flatten(pbwio_cloud *cloud)
{
    size_t i;
    for (i = 0; i < cloud->count; i++) {
        if (cloud->points[3 * i + 2] < cloud->points[2] || cloud->points[3 * i + 2] > cloud->points[2]) {
            return;
        }
    }
    for (i = 0; i < cloud->count; i++) {
        memmove(cloud->points + 2 * i, cloud->points + 3 * i, 2 * sizeof(double));
    }
    cloud->dim = 2;
}

static int load(job *j)
{
    double start = now();
    pbwio_error error;
    if (j->generate != NULL) {
        if (!pbwgen_points(j->kind, j->read.dim == 2 ? 2 : 3, j->count, j->sample.seed, &j->cloud)) {
            return fail(j, "out of memory");
        }
    } else if (pbwio_read(j->input, &j->read, &j->cloud, &error) != PBWIO_OK) {
        return fail(j, error.text);
    }
    if (j->read.dim == 0 && j->cloud.dim == 3 && j->command & (SHOWN | CHECK | BENCH)) {
        flatten(&j->cloud);
    }
    if (!j->on[QUIET]) {
        printf("%zu points in %dD%s, %zu faces\n", j->cloud.count, j->cloud.dim,
               j->cloud.weights != NULL ? ", weighted" : "", j->cloud.triangle_count);
    }
    say(j, "read", now() - start, "");
    return interrupted ? fail(j, "cancelled") : 0;
}

static int build(job *j)
{
    pbw_status status;
    int i;
    for (i = 0; i < j->outputs && j->build.trace == NULL; i++) {
        if (has_ending(j->output[i], ".html")) {     /* pages can show who inserted what; not if memory is short */
            j->build.trace = (uint32_t *)malloc((j->cloud.count + 1) * sizeof(uint32_t));
        }
    }
    status = pbw_triangulate(j->cloud.dim, j->cloud.points, j->cloud.weights, j->cloud.count, &j->build, &j->mesh);
    if (status != PBW_OK) {
        return fail(j, status == PBW_CANCELLED ? "cancelled" : pbw_status_string(status));
    }
    say(j, "order", j->mesh.statistics.order_seconds, "");
    say(j, "build", j->mesh.statistics.build_seconds, "");
    say(j, "output", j->mesh.statistics.output_seconds, "");
    return 0;
}

static int check(job *j)
{
    double start = now();
    pbw_report report;
    pbw_status status = pbw_check(&j->mesh, &j->build, &report);
    if (status != PBW_OK) {
        return fail(j, status == PBW_CANCELLED ? "cancelled" : pbw_status_string(status));
    }
    say(j, "check", now() - start, report.valid ? "valid" : report.what);
    return report.valid ? 0 : fail(j, "the result is wrong: please report this");
}

static void describe(const job *j)
{
    size_t i, hull = 0;
    for (i = 0; i < j->mesh.simplex_count * (size_t)(j->mesh.dim + 1); i++) {
        hull += j->mesh.neighbors[i] == PBW_NONE;
    }
    if (!j->on[QUIET]) {
        printf("%zu %s, %zu on the hull, %zu duplicates, %zu hidden points\n", j->mesh.simplex_count,
               j->mesh.dim == 3 ? "tetrahedra" : "triangles", hull, j->mesh.duplicate_count, j->mesh.hidden_count);
        printf("peak memory %.0f bytes a point, hash %016llx\n",
               (double)j->mesh.statistics.peak_bytes / (double)j->mesh.point_count,
               (unsigned long long)pbw_hash(&j->mesh, NULL));
    }
}

static pbwsample_model model_of(const pbwio_cloud *cloud)
{
    pbwsample_model model;
    memset(&model, 0, sizeof model);
    model.points = cloud->points;
    model.point_count = cloud->count;
    model.triangles = cloud->triangles;
    model.triangle_count = cloud->triangle_count;
    return model;
}

/* Marks the tetrahedra whose centre is inside the surface. */
static int mark_inside(job *j)
{
    const pbwio_cloud *surface = &j->cloud;
    pbwsample_model model;
    pbwsample_status status = PBWSAMPLE_ERROR_MEMORY;
    pbwio_error error;
    double start = now(), *centre;
    unsigned char *inside;
    size_t i, k, kept = 0;
    if (j->surface != NULL) {
        if (pbwio_read(j->surface, NULL, &j->surface_cloud, &error) != PBWIO_OK) {
            return fail(j, error.text);
        }
        surface = &j->surface_cloud;
    }
    if (j->mesh.dim != 3 || surface->dim != 3 || surface->triangle_count == 0) {
        return fail(j, "--inside needs a model with faces in 3D");
    }
    model = model_of(surface);
    centre = (double *)calloc(j->mesh.simplex_count + 1, 3 * sizeof *centre);
    j->write.keep = j->picture.keep = inside = (unsigned char *)calloc(j->mesh.simplex_count + 1, 1);
    for (i = 0; i < j->mesh.simplex_count && centre != NULL; i++) {
        for (k = 0; k < 12; k++) {
            centre[3 * i + k % 3] += 0.25 * j->mesh.points[3 * (size_t)j->mesh.simplices[4 * i + k / 3] + k % 3];
        }
    }
    if (centre != NULL && inside != NULL) {
        status = pbwsample_inside(&model, centre, j->mesh.simplex_count, inside);
    }
    free(centre);
    if (status != PBWSAMPLE_OK) {
        return fail(j, pbwsample_status_string(status));
    }
    for (i = 0; i < j->mesh.simplex_count; i++) {
        kept += inside[i];
    }
    snprintf(error.text, sizeof error.text, "%zu tetrahedra", kept);
    say(j, "inside", now() - start, error.text);
    return 0;
}

static void add_array(pbwview_options *view, const char *name, const uint32_t *whole, const double *real,
                      int of_points, int classes)
{
    pbwview_array *array = (pbwview_array *)(uintptr_t)(view->arrays + view->array_count++);
    memset(array, 0, sizeof *array);
    array->name = name;
    array->whole = whole;
    array->real = real;
    array->of_points = of_points;
    array->classes = classes;
}

static pbwio_status write_page(const job *j, const char *path, pbwio_error *error)
{
    const pbw_mesh *mesh = &j->mesh;
    const char *slash = j->input == NULL ? NULL : strrchr(j->input, '/');
    size_t parts = j->build.threads > 0 ? (size_t)j->build.threads : 8, count = mesh->simplex_count, i;
    size_t traced = j->build.trace != NULL ? mesh->point_count : 0;
    uint32_t *part = (uint32_t *)malloc((count + 1) * sizeof *part);
    uint32_t *order = (uint32_t *)malloc((mesh->point_count + 1) * sizeof *order);
    uint32_t *thread = (uint32_t *)malloc((traced + 1) * sizeof *thread);
    uint32_t *round = (uint32_t *)malloc((traced + 1) * sizeof *round);
    pbwview_array arrays[5];
    pbwview_options view;
    pbwio_status status = PBWIO_ERROR_MEMORY;
    char note[128] = "";
    memset(&view, 0, sizeof view);
    snprintf(error->text, sizeof error->text, "out of memory");
    if (mesh->duplicate_count + mesh->hidden_count > 0) {
        snprintf(note, sizeof note, "%zu duplicate and %zu hidden points left out", mesh->duplicate_count,
                 mesh->hidden_count);
    }
    view.title = j->title != NULL ? j->title : j->generate != NULL ? j->generate
               : slash != NULL ? slash + 1 : j->input;
    view.note = note;
    view.keep = j->picture.keep;
    view.colour = j->colour;
    view.cut_through = j->on[CUT_THROUGH];
    view.colour_outside = j->on[COLOUR_OUTSIDE];
    memcpy(view.eye, j->picture.eye, sizeof view.eye);
    memcpy(view.up, j->picture.up, sizeof view.up);
    memcpy(view.cut, j->picture.cut, sizeof view.cut);
    view.arrays = arrays;
    add_array(&view, "order", order, NULL, 1, 0);
    add_array(&view, "part", part, NULL, 0, 1);
    if (traced > 0) {
        add_array(&view, "thread", thread, NULL, 1, 1);
        add_array(&view, "round", round, NULL, 1, 0);
    }
    if (mesh->weights != NULL) {
        add_array(&view, "weight", NULL, mesh->weights, 1, 0);
    }
    if (part != NULL && order != NULL && thread != NULL && round != NULL) {
        for (i = 0; i < count; i++) {                /* simplices follow the curve */
            part[i] = (uint32_t)(i * parts / count);
        }
        for (i = 0; i < mesh->point_count; i++) {
            order[i] = (uint32_t)i;
        }
        for (i = 0; i < traced; i++) {               /* duplicates were inserted by nobody, and are in no simplex */
            thread[i] = j->build.trace[i] == PBW_NONE ? 0 : j->build.trace[i] % 256;
            round[i] = j->build.trace[i] == PBW_NONE ? 0 : j->build.trace[i] / 256;
        }
        status = pbwview_write(path, mesh, &view, error);
    }
    free(part);
    free(order);
    free(thread);
    free(round);
    return status;
}

static int write_mesh(const job *j)
{
    int i;
    for (i = 0; i < j->outputs; i++) {
        double start = now();
        pbwio_error error;
        const char *path = j->output[i];
        pbwio_status status = has_ending(path, ".svg") ? pbwpic_write(path, &j->mesh, &j->picture, &error)
            : has_ending(path, ".html") ? write_page(j, path, &error)
            : pbwio_write(path, &j->mesh, &j->write, &error);
        if (status != PBWIO_OK || interrupted) {
            return fail(j, status != PBWIO_OK ? error.text : "cancelled");
        }
        say(j, "write", now() - start, path);
    }
    return 0;
}

static int write_model(const job *j, const pbwmodel_content *content)
{
    int i;
    for (i = 0; i < j->outputs; i++) {
        double start = now();
        pbwio_error error;
        if (pbwmodel_write(j->output[i], content, j->write.flags, &error) != PBWIO_OK || interrupted) {
            return fail(j, interrupted ? "cancelled" : error.text);
        }
        say(j, "write", now() - start, j->output[i]);
    }
    return 0;
}

/* Faults of a surface, by number; returns whether it has an inside. */
static int describe_surface(job *j, const pbwsample_model *model)
{
    double start = now();
    pbwsample_report report;
    pbwsample_status status = pbwsample_inspect(model, &report);
    char text[256] = "";
    if (status != PBWSAMPLE_OK) {
        say(j, "surface", now() - start, pbwsample_status_string(status));
        return 0;
    }
    snprintf(text, sizeof text, report.closed ? "closed" : "%zu open, %zu crowded, %zu turned edges",
             report.open_edges, report.crowded_edges, report.turned_edges);
    say(j, "surface", now() - start, text);
    if (!j->on[QUIET]) {
        printf("area %g, volume %g, %zu flat faces, %zu unused and %zu duplicate points\n", report.area,
               report.volume, report.flat_triangles, report.unused_points, report.duplicate_points);
    }
    return report.closed;
}

/* ---- commands ---- */

static int run_mesh(job *j)
{
    int status = load(j);
    status = status != 0 ? status : build(j);
    status = status != 0 || j->on[NO_CHECK] ? status : check(j);
    if (status == 0) {
        describe(j);
    }
    status = status != 0 || !j->on[INSIDE] ? status : mark_inside(j);
    return status != 0 ? status : write_mesh(j);
}

static int run_view(job *j)
{
    int status = load(j);
    if (status == 0 && j->on[POINTS]) {
        j->mesh.dim = j->cloud.dim;                                  /* borrowed: nothing in it is pbw_free's */
        j->mesh.points = j->cloud.points;
        j->mesh.point_count = j->cloud.count;
    } else if (status == 0) {
        status = build(j);
        if (status == 0) {
            describe(j);
        }
        status = status != 0 || !j->on[INSIDE] ? status : mark_inside(j);
    }
    status = status != 0 ? status : write_mesh(j);
    if (status == 0 && !j->on[QUIET]) {
        printf("open this in a browser: %s\n", j->output[j->outputs - 1]);
    }
    return status;
}

static int run_sample(job *j)
{
    pbwsample_model model;
    pbwsample_status status;
    pbwmodel_content content;
    char text[128];
    double start;
    size_t surface;
    int failed;
    j->read.dim = 3;
    failed = load(j);
    if (failed) {
        return failed;
    }
    model = model_of(&j->cloud);
    if (model.triangle_count == 0) {
        return fail(j, "a model with faces is needed");
    }
    if (pbwmodel_read_normals(j->input, &j->cloud, &j->normals)) {
        model.normals = j->normals.points;
        model.normal_count = j->normals.count;
        model.normal_ids = j->normals.triangles;
    }
    describe_surface(j, &model);
    j->sample.count = j->sample.count == 0 && !(j->sample.radius > 0) ? 20000 : j->sample.count;
    j->sample.flags = PBWSAMPLE_NORMALS | (j->on[THIN] ? PBWSAMPLE_THIN : 0)
                    | (j->on[FACET_NORMALS] ? PBWSAMPLE_FACET_NORMALS : 0);
    start = now();
    status = j->on[UNIFORM] ? pbwsample_uniform(&model, &j->sample, &j->samples)
                            : pbwsample_poisson(&model, &j->sample, &j->samples);
    surface = j->samples.count;
    if (status == PBWSAMPLE_OK) {
        snprintf(text, sizeof text, "%zu points", surface);
        if (!j->on[UNIFORM]) {
            snprintf(text, sizeof text, "%zu points, none closer than %g", surface, j->samples.radius);
        }
        say(j, "sample", now() - start, text);
    }
    if (status == PBWSAMPLE_OK && j->fill > 0) {
        start = now();
        j->sample.count = 0;
        j->sample.radius = 0;
        j->sample.flags |= j->fill == 1 ? PBWSAMPLE_LATTICE : 0;
        status = pbwsample_volume(&model, &j->sample, &j->samples);
        snprintf(text, sizeof text, "%zu points inside", j->samples.count - surface);
        if (status == PBWSAMPLE_OK) {
            say(j, "fill", now() - start, text);
        }
    }
    if (status != PBWSAMPLE_OK) {
        return fail(j, pbwsample_status_string(status));
    }
    memset(&content, 0, sizeof content);
    content.dim = 3;
    content.points = j->samples.points;
    content.point_count = j->samples.count;
    content.normals = j->fill > 0 ? NULL : j->samples.normals;       /* there are none inside */
    return write_model(j, &content);
}

static int run_check(job *j)
{
    int status = load(j), closed = 1;
    if (status == 0 && j->cloud.triangle_count > 0 && j->cloud.dim == 3) {
        pbwsample_model model = model_of(&j->cloud);
        closed = describe_surface(j, &model);
    }
    status = status != 0 ? status : build(j);
    status = status != 0 ? status : check(j);
    if (status == 0) {
        describe(j);
    }
    return status != 0 ? status : closed ? 0 : fail(j, "the surface has faults");
}

static int run_convert(job *j)
{
    pbwmodel_content content;
    int failed = load(j);
    double *normals = NULL;
    size_t i;
    if (failed) {
        return failed;
    }
    memset(&content, 0, sizeof content);
    content.dim = j->cloud.dim;
    content.points = j->cloud.points;
    content.point_count = j->cloud.count;
    content.triangles = j->cloud.triangles;
    content.triangle_count = j->cloud.triangle_count;
    if (j->input != NULL && pbwmodel_read_normals(j->input, &j->cloud, &j->normals)) {
        normals = (double *)calloc(j->cloud.count, 3 * sizeof *normals);
        for (i = 0; normals != NULL && i < 3 * j->cloud.triangle_count; i++) {     /* one a point: the last */
            memcpy(normals + 3 * (size_t)j->cloud.triangles[i],
                   j->normals.points + 3 * (size_t)j->normals.triangles[i], 3 * sizeof *normals);
        }
        content.normals = j->cloud.triangle_count > 0 ? normals : j->normals.points;
    }
    failed = write_model(j, &content);
    free(normals);
    return failed;
}

static int run_bench(job *j)
{
    int status = load(j), run, threads, most = j->build.threads;
    uint64_t hash = 0;
    if (most == 0) {
#ifdef _SC_NPROCESSORS_ONLN
        most = (int)sysconf(_SC_NPROCESSORS_ONLN);
#endif
        most = most < 1 ? 1 : most > 256 ? 256 : most;
    }
    if (status == 0) {
        printf("threads   seconds   M points/s   bytes/point   simplices   hash\n");
    }
    for (threads = 1; status == 0; threads = 2 * threads < most ? 2 * threads : most) {
        double best = DBL_MAX;
        for (run = 0; run < 3 && status == 0; run++) {
            double start = now();
            pbw_status built;
            pbw_free(&j->mesh);
            j->build.threads = threads;
            built = pbw_triangulate(j->cloud.dim, j->cloud.points, j->cloud.weights, j->cloud.count, &j->build,
                                    &j->mesh);
            best = now() - start < best ? now() - start : best;
            if (built != PBW_OK) {
                status = fail(j, built == PBW_CANCELLED ? "cancelled" : pbw_status_string(built));
            }
        }
        if (status == 0) {
            uint64_t found = pbw_hash(&j->mesh, NULL);
            fputs(j->terminal ? "\r\033[K" : "", stderr);
            printf("%7d %9.3f %12.3f %13.0f %11zu   %016llx\n", threads, best, (double)j->cloud.count / best * 1e-6,
                   (double)j->mesh.statistics.peak_bytes / (double)j->cloud.count, j->mesh.simplex_count,
                   (unsigned long long)found);
            fflush(stdout);
            if (threads > 1 && found != hash) {
                status = fail(j, "the result is wrong: please report this");
            }
            hash = found;
        }
        if (threads == most) {
            break;
        }
    }
    return status != 0 ? status : check(j);
}

int main(int argc, char **argv)
{
    job j;
    int status;
    memset(&j, 0, sizeof j);
    j.sample.seed = 1;
    status = parse(argc, argv, &j);
    if (status != 0) {
        return status - 1;
    }
    j.terminal = !j.on[QUIET] && isatty(2);
    j.build.progress = on_progress;
    j.sample.progress = on_sampled;
    j.build.progress_user = j.sample.progress_user = &j;
    signal(SIGINT, on_interrupt);
    switch (j.command) {
        case SAMPLE: status = run_sample(&j); break;
        case CHECK: status = run_check(&j); break;
        case CONVERT: status = run_convert(&j); break;
        case BENCH: status = run_bench(&j); break;
        case VIEW: status = run_view(&j); break;
        default: status = run_mesh(&j);
    }
    free((void *)j.write.keep);
    free(j.build.trace);
    pbw_free(&j.mesh);
    pbwio_free(&j.cloud);
    pbwio_free(&j.normals);
    pbwio_free(&j.surface_cloud);
    pbwsample_free(&j.samples);
    return status;
}
