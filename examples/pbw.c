/* pbw.c: triangulates a file of points or a model, checks the result, writes it and draws it.
   cc -O2 -I. examples/pbw.c -o pbw -lpthread -lm
   ./pbw model.obj -o model.vtu -o model.svg;  ./pbw --help lists the rest. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_IO_IMPLEMENTATION
#include "pbw_io.h"
#define PBW_PICTURE_IMPLEMENTATION
#include "pbw_picture.h"
#include <signal.h>
#ifdef _WIN32
#include <io.h>
#define isatty _isatty
#else
#include <sys/time.h>
#include <unistd.h>
#endif

enum { MOST_OUTPUTS = 32, FAILURE = 1, USAGE = 2 };

static const char help[] =
    "usage: pbw [options] input [-o output]...\n"
    "\n"
    "Exact Delaunay triangulation of the points of a file, or with --weights the regular one.\n"
    "\n"
    "input:   .obj .ply .stl .off .node, tables (.xyz .csv .txt ...); - is the standard input\n"
    "output:  .vtu .msh .mesh .node .ele .neigh (simplices), .obj .ply .stl (hull), .xyz .csv (points),\n"
    "         .svg (picture); any number of them\n"
    "\n"
    "  --dim 2|3             dimension; default 3, or 2 for files of two columns or of one z\n"
    "  --columns X,Y[,Z]     which columns, by number from 1 or by name\n"
    "  --weights COLUMN      regular triangulation with the weights of that column\n"
    "  --generate KIND N     N points instead of an input: uniform gauss ball sphere lattice clusters lines\n"
    "                        spiral plane anisotropic moment\n"
    "  --seed S              for --generate, up to 1000000; default 1\n"
    "  --threads N           default: all cores\n"
    "  --memory-limit SIZE   such as 500M or 4G: fail rather than use more for the triangulation\n"
    "  --any-order           skip the canonical order of simplices\n"
    "  --no-check            skip the exact check of the result\n"
    "  --inside              output only what is inside the closed surface of the model\n"
    "  --no-orphans          leave points that are corners of nothing out of the output\n"
    "  --text                text instead of binary output\n"
    "  --eye X,Y,Z           pictures: direction to the viewer\n"
    "  --up X,Y,Z            pictures: upwards; default 0,0,1\n"
    "  --cut A,B,C,D         pictures: cut away Ax+By+Cz > D, D from -1 to 1; D = 1 cuts nothing\n"
    "  --quiet               print errors only\n"
    "  --help, --version\n"
    "\n"
    "exit status: 0 done, 1 failure, 2 wrong usage\n";

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

/* A bar on the terminal; user: whether there is one. */
static int on_progress(void *user, pbw_stage stage, double done)
{
    static const char *const names[] = { "order", "build", "output", "check" };
    int length = (int)(40 * done);
    if (*(int *)user) {
        fprintf(stderr, "\r%-6s [%.*s%*s] %3.0f %%", names[stage], length, "########################################",
                40 - length, "", 100 * done);
    }
    return interrupted;
}

/* ---- points without a file ---- */

static uint64_t random_state;

static double mixed(uint64_t z)                      /* splitmix64 (Steele, Lea and Flood 2014), to [0, 1) */
{
    z *= 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static double uniform(void)
{
    return mixed(++random_state);
}

static double gauss(void)                            /* nearly: the sum of twelve uniform ones */
{
    double sum = -6;
    int i;
    for (i = 0; i < 12; i++) {
        sum += uniform();
    }
    return sum;
}

static const char *const kinds[] = { "uniform", "gauss", "ball", "sphere", "lattice", "clusters", "lines", "spiral",
                                     "plane", "anisotropic", "moment", NULL };

static void generate_point(int kind, int dim, size_t i, size_t count, double *p)
{
    double t = ((double)i + 0.5) / (double)count, length = 2, turn = 6.283185307179586;
    uint64_t few = i % 32, many = i % (1 + (size_t)sqrt((double)count));
    size_t side = (size_t)ceil(pow((double)count, 1.0 / dim) - 1e-9), rest = i;
    int k;
    for (k = 0; k < dim; k++) {
        p[k] = kind == 1 || kind == 5 ? gauss() : uniform();
    }
    if (kind == 2 || kind == 3) {                    /* ball, sphere */
        while (!(length <= 1 && length > 1e-6)) {
            for (k = 0, length = 0; k < dim; k++) {
                p[k] = 2 * uniform() - 1;
                length += p[k] * p[k];
            }
        }
        for (k = 0; k < dim; k++) {
            p[k] /= kind == 3 ? sqrt(length) : 1;
        }
    } else if (kind == 4) {                          /* lattice */
        for (k = 0; k < dim; k++, rest /= side) {
            p[k] = (double)(rest % side);
        }
    } else if (kind == 5) {                          /* 32 clusters, from wide to narrow */
        for (k = 0; k < dim; k++) {
            p[k] = mixed(1 + 3 * few + (uint64_t)k) + p[k] * 0.1 / (double)(1 + few * few);
        }
    } else if (kind == 6) {                          /* as many lines, along the axes, as points on each */
        for (k = 0; k < dim; k++) {
            p[k] = (uint64_t)k == many % (uint64_t)dim ? p[k] : mixed(1 + 3 * many + (uint64_t)k);
        }
    } else if (kind == 7) {                          /* a sunflower; in 3D bent to a bowl */
        p[dim - 1] = t;
        p[0] = sqrt(t) * cos(turn * 0.3819660112501051 * (double)i);
        p[1] = sqrt(t) * sin(turn * 0.3819660112501051 * (double)i);
    } else if (kind == 8 || kind == 9) {             /* plane, anisotropic */
        p[dim - 1] *= kind == 8 ? 1e-9 : 1e-3;
        p[0] *= kind == 9 ? 1e3 : 1;
    } else if (kind == 10) {                         /* moment curve: in 3D every two points share a simplex */
        for (k = 0; k < dim; k++) {
            p[k] = pow(t, k + 1);
        }
    }
}

static int generate(int kind, int dim, size_t count, uint64_t seed, pbwio_cloud *cloud)
{
    size_t i;
    memset(cloud, 0, sizeof *cloud);
    if (count < (size_t)-1 / 32) {
        cloud->points = (double *)malloc((count + 1) * (size_t)dim * sizeof(double));
    }
    if (cloud->points == NULL) {
        return 0;
    }
    random_state = seed << 40;
    cloud->dim = dim;
    cloud->count = count;
    for (i = 0; i < count; i++) {
        generate_point(kind, dim, i, count, cloud->points + i * (size_t)dim);
    }
    return 1;
}

/* ---- inside and outside ---- */

/* The side of the line through projected points a and b that p is on; on the line, one that depends on the points
   only, so that the triangles at an edge agree. */
static int side(const double *points, pbw_index a, pbw_index b, const double *p)
{
    int sign = a < b ? pbw_orient2(points + 3 * (size_t)a, points + 3 * (size_t)b, p)
                     : -pbw_orient2(points + 3 * (size_t)b, points + 3 * (size_t)a, p);
    return sign != 0 ? sign : a < b ? 1 : -1;
}

typedef struct columns {                             /* a grid over x and y; which triangles are over each cell */
    size_t side, *first;                             /* first[c] to first[c+1] in list are those over cell c */
    pbw_index *list;
    double low[2], scale[2];
} columns;

static size_t cell_of(const columns *grid, double x, int axis)
{
    double at = (x - grid->low[axis]) * grid->scale[axis];
    return at < 0 ? 0 : at >= (double)grid->side ? grid->side - 1 : (size_t)at;
}

static int sort_into_columns(columns *grid, const pbwio_cloud *model)
{
    size_t i, x, y, total = 0;
    double high[2] = { -DBL_MAX, -DBL_MAX }, least[2], most[2];
    int k, pass;
    memset(grid, 0, sizeof *grid);
    grid->side = (size_t)fmin(1024, sqrt((double)model->triangle_count / 2) + 1);
    grid->first = (size_t *)calloc(grid->side * grid->side + 1, sizeof *grid->first);
    grid->low[0] = grid->low[1] = DBL_MAX;
    for (i = 0; i < model->count; i++) {
        for (k = 0; k < 2; k++) {
            grid->low[k] = fmin(grid->low[k], model->points[3 * i + (size_t)k]);
            high[k] = fmax(high[k], model->points[3 * i + (size_t)k]);
            grid->scale[k] = (double)grid->side / (high[k] > grid->low[k] ? high[k] - grid->low[k] : 1);
        }
    }
    for (pass = 0; pass < 2 && grid->first != NULL; pass++) {        /* count, then fill from the back */
        for (i = 0; i < model->triangle_count; i++) {
            const pbw_index *t = model->triangles + 3 * i;
            for (k = 0; k < 2; k++) {
                const double *p = model->points + k;
                least[k] = fmin(p[3 * (size_t)t[0]], fmin(p[3 * (size_t)t[1]], p[3 * (size_t)t[2]]));
                most[k] = fmax(p[3 * (size_t)t[0]], fmax(p[3 * (size_t)t[1]], p[3 * (size_t)t[2]]));
            }
            for (y = cell_of(grid, least[1], 1); y <= cell_of(grid, most[1], 1); y++) {
                for (x = cell_of(grid, least[0], 0); x <= cell_of(grid, most[0], 0); x++) {
                    if (pass == 0) {
                        grid->first[y * grid->side + x]++;
                    } else {
                        grid->list[--grid->first[y * grid->side + x]] = (pbw_index)i;
                    }
                }
            }
        }
        for (i = 0; pass == 0 && i <= grid->side * grid->side; i++) {
            grid->first[i] = total += grid->first[i];
        }
        if (pass == 0 && (grid->list = (pbw_index *)malloc((total + 1) * sizeof *grid->list)) == NULL) {
            return 0;
        }
    }
    return grid->first != NULL;
}

/* Marks the simplices whose centre is inside the closed surface: a ray upwards leaves it an odd number of times. */
static unsigned char *find_inside(const pbw_mesh *mesh, const pbwio_cloud *model)
{
    unsigned char *inside = (unsigned char *)calloc(mesh->simplex_count + 1, 1);
    const double *q = model->points;
    columns grid;
    size_t i, j, cell;
    int found = sort_into_columns(&grid, model);
    for (i = 0; i < mesh->simplex_count && found && inside != NULL; i++) {
        double p[3] = { 0, 0, 0 };
        for (j = 0; j < 12; j++) {
            p[j % 3] += 0.25 * mesh->points[3 * (size_t)mesh->simplices[4 * i + j / 3] + j % 3];
        }
        cell = cell_of(&grid, p[1], 1) * grid.side + cell_of(&grid, p[0], 0);
        for (j = grid.first[cell]; j < grid.first[cell + 1]; j++) {
            const pbw_index *t = model->triangles + 3 * (size_t)grid.list[j];
            int turn = side(q, t[0], t[1], p);
            if (side(q, t[1], t[2], p) == turn && side(q, t[2], t[0], p) == turn) {
                const double *a = q + 3 * (size_t)t[0], *b = q + 3 * (size_t)t[1], *c = q + 3 * (size_t)t[2];
                inside[i] = (unsigned char)(inside[i] ^ (pbw_orient3(a, b, c, p) * turn < 0));
            }
        }
    }
    free(grid.first);
    free(grid.list);
    if (!found) {
        free(inside);
        inside = NULL;
    }
    return inside;
}

/* ---- the program ---- */

typedef struct job {
    const char *input, *output[MOST_OUTPUTS], *generate;
    int outputs, kind, terminal, on[6];              /* on: the switches below */
    size_t count;
    uint64_t seed;
    pbwio_options read;
    pbwio_output write;
    pbwpic_options picture;
    pbw_options build;
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

enum { QUIET, NO_CHECK, ANY_ORDER, INSIDE, NO_ORPHANS, TEXT };
static const char *const switches[] = { "--quiet", "--no-check", "--any-order", "--inside", "--no-orphans", "--text",
                                        NULL };

enum { O, DIM, COLUMNS, WEIGHTS, THREADS, MEMORY_LIMIT, SEED, EYE, UP, CUT, GENERATE };
static const char *const settings[] = { "-o", "--dim", "--columns", "--weights", "--threads", "--memory-limit",
                                        "--seed", "--eye", "--up", "--cut", "--generate", NULL };

/* The setting of that number; returns whether the value is proper.  more: the argument after the value or NULL. */
static int set(job *j, int setting, const char *value, const char *more)
{
    const char *dot = strrchr(value, '.');
    pbwio_format format = pbwio_format_of(value);
    double n = 0;
    int fine = 1;
    switch (setting) {
        case O:
            j->output[j->outputs % MOST_OUTPUTS] = value;
            return ++j->outputs <= MOST_OUTPUTS && (format != PBWIO_AUTO || (dot != NULL && strcmp(dot, ".svg") == 0))
                && format != PBWIO_OFF;
        case DIM: fine = whole(value, 2, 3, &n); j->read.dim = (int)n; break;
        case COLUMNS: j->read.columns = value; break;
        case WEIGHTS: j->read.weight = value; break;
        case THREADS: fine = whole(value, 0, 256, &n); j->build.threads = (int)n; break;
        case MEMORY_LIMIT:
            fine = whole(value, 1, (double)((size_t)-1 / 2), &n);
            j->build.memory_limit = (size_t)n;
            break;
        case SEED: fine = whole(value, 0, 1e6, &n); j->seed = (uint64_t)n; break;
        case EYE: return numbers(value, 3, j->picture.eye);
        case UP: return numbers(value, 3, j->picture.up);
        case CUT: return numbers(value, 4, j->picture.cut);
        default:
            j->generate = value;
            j->kind = find(kinds, value);
            fine = j->kind >= 0 && more != NULL && whole(more, 1, 4e9, &n);
            j->count = (size_t)n;
    }
    return fine;
}

/* Fills the job; returns 0, or the exit status plus one. */
static int parse(int argc, char **argv, job *j)
{
    int i, k;
    for (i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) {
            fputs(help, stdout);
            return 1;
        } else if (strcmp(argv[i], "--version") == 0) {
            printf("pbw %d.%d.%d\n", PBW_VERSION_MAJOR, PBW_VERSION_MINOR, PBW_VERSION_PATCH);
            return 1;
        } else if ((k = find(switches, argv[i])) >= 0) {
            j->on[k] = 1;
        } else if ((k = find(settings, argv[i])) >= 0) {
            if (i + 1 >= argc || !set(j, k, argv[i + 1], argv[i + 2 < argc ? i + 2 : argc])) {
                return 1 + complain("no proper value for ", argv[i]);
            }
            i += k == GENERATE ? 2 : 1;
        } else if (argv[i][0] == '-' && argv[i][1] != 0) {
            return 1 + complain("unknown option ", argv[i]);
        } else if (j->input != NULL) {
            return 1 + complain("more than one input: ", argv[i]);
        } else {
            j->input = argv[i];
        }
    }
    if ((j->input == NULL) == (j->generate == NULL)) {
        return 1 + complain("one input or --generate is needed; see --help", "");
    }
    j->build.flags = j->on[ANY_ORDER] ? PBW_ANY_ORDER : 0;
    j->write.flags = (j->on[NO_ORPHANS] ? PBWIO_NO_ORPHANS : 0) | (j->on[TEXT] ? PBWIO_TEXT : 0);
    return 0;
}

static int fail(const char *what)
{
    fflush(stdout);
    fprintf(stderr, "pbw: %s\n", what);
    return FAILURE;
}

static int fail_with(const job *j, pbw_status status)
{
    fputs(j->terminal ? "\r\033[K" : "", stderr);                   /* the bar */
    return fail(status == PBW_CANCELLED ? "cancelled" : pbw_status_string(status));
}

/* A line of the report. */
static void tell(const job *j, const char *what, double seconds, const char *more)
{
    fputs(j->terminal ? "\r\033[K" : "", stderr);
    if (!j->on[QUIET]) {
        printf("%-9s %8.3f s%s%s\n", what, seconds, *more != 0 ? "   " : "", more);
        fflush(stdout);
    }
}

/* Writes all outputs; returns the exit status. */
static int write_all(const job *j, const pbw_mesh *mesh)
{
    int i;
    for (i = 0; i < j->outputs; i++) {
        double start = now();
        pbwio_error error;
        pbwio_status status = pbwio_format_of(j->output[i]) != PBWIO_AUTO
            ? pbwio_write(j->output[i], mesh, &j->write, &error)
            : pbwpic_write(j->output[i], mesh, &j->picture, &error);
        if (status != PBWIO_OK || interrupted) {
            return fail(status != PBWIO_OK ? error.text : "cancelled");
        }
        tell(j, "write", now() - start, j->output[i]);
    }
    return 0;
}

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

static int run(job *j, pbwio_cloud *cloud, pbw_mesh *mesh)
{
    double start = now();
    size_t i, hull = 0, kept = 0;
    unsigned char *inside;
    pbw_status status;
    pbw_report report;
    pbwio_error error;
    if (j->generate != NULL && !generate(j->kind, j->read.dim == 2 ? 2 : 3, j->count, j->seed, cloud)) {
        return fail("out of memory");
    }
    if (j->generate == NULL && pbwio_read(j->input, &j->read, cloud, &error) != PBWIO_OK) {
        return fail(error.text);
    }
    if (j->read.dim == 0 && cloud->dim == 3) {
        flatten(cloud);
    }
    if (!j->on[QUIET]) {
        printf("%zu points in %dD%s, %zu faces\n", cloud->count, cloud->dim,
               cloud->weights != NULL ? ", weighted" : "", cloud->triangle_count);
    }
    tell(j, "read", now() - start, "");
    status = interrupted ? PBW_CANCELLED
           : pbw_triangulate(cloud->dim, cloud->points, cloud->weights, cloud->count, &j->build, mesh);
    if (status != PBW_OK) {
        return fail_with(j, status);
    }
    tell(j, "order", mesh->statistics.order_seconds, "");
    tell(j, "build", mesh->statistics.build_seconds, "");
    tell(j, "output", mesh->statistics.output_seconds, "");
    if (!j->on[NO_CHECK]) {
        start = now();
        status = pbw_check(mesh, &j->build, &report);
        if (status != PBW_OK) {
            return fail_with(j, status);
        }
        tell(j, "check", now() - start, report.valid ? "valid" : report.what);
        if (!report.valid) {
            return fail("the result is wrong: please report this");
        }
    }
    for (i = 0; i < mesh->simplex_count * (size_t)(mesh->dim + 1); i++) {
        hull += mesh->neighbors[i] == PBW_NONE;
    }
    if (!j->on[QUIET]) {
        printf("%zu %s, %zu on the hull, %zu duplicates, %zu hidden points\n", mesh->simplex_count,
               mesh->dim == 3 ? "tetrahedra" : "triangles", hull, mesh->duplicate_count, mesh->hidden_count);
        printf("peak memory %.0f bytes a point, hash %016llx\n",
               (double)mesh->statistics.peak_bytes / (double)mesh->point_count, (unsigned long long)pbw_hash(mesh));
    }
    if (j->on[INSIDE]) {
        if (mesh->dim != 3 || cloud->triangle_count == 0) {
            return fail("--inside needs a model with faces in 3D");
        }
        start = now();
        inside = find_inside(mesh, cloud);
        if (inside == NULL) {
            return fail("out of memory");
        }
        for (i = 0; i < mesh->simplex_count; i++) {
            kept += inside[i];
        }
        j->write.keep = j->picture.keep = inside;
        snprintf(error.text, sizeof error.text, "%zu tetrahedra", kept);
        tell(j, "inside", now() - start, error.text);
    }
    return write_all(j, mesh);
}

int main(int argc, char **argv)
{
    job j;
    pbwio_cloud cloud;
    pbw_mesh mesh;
    int status;
    memset(&j, 0, sizeof j);
    memset(&cloud, 0, sizeof cloud);
    memset(&mesh, 0, sizeof mesh);
    j.seed = 1;
    status = parse(argc, argv, &j);
    if (status != 0) {
        return status - 1;
    }
    j.terminal = !j.on[QUIET] && isatty(2);
    j.build.progress = on_progress;
    j.build.progress_user = &j.terminal;
    signal(SIGINT, on_interrupt);
    status = run(&j, &cloud, &mesh);
    free((void *)j.write.keep);
    pbw_free(&mesh);
    pbwio_free(&cloud);
    return status;
}
