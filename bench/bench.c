/* bench.c: pbw and its rivals on the same points, in one table

   METHOD
     Every sample is taken in a process of its own, forked from this one after the points have been made, so all
     start with the same cold heap and none gains or suffers from what ran before.  Timed is the way from points in
     memory to the triangulation in memory; turning the points into the form that a library takes, and freeing, are
     not.  Builds of less than 50 ms are repeated until 50 ms are over, and the sample is their mean.
     pbw and its rivals take turns, one sample each, until a side has --repeats samples or has used up --budget
     seconds: a busy machine slows all sides alike.  Do not read anything into gaps under a tenth, and look at the
     load that the first lines report.
     In the first round pbw_check judges our result, exactly, after the clock has stopped.

   THE TABLE
     thr           threads of both sides; but CGAL has one in 2D, whatever we have
     pbw, rival    the best sample; the median
     ratio         our best / the rival's best: below 1 we are faster
     runs          samples, ours:the rival's
     B/pt          bytes per point above the input at the peak: ours by the library's own count; "RSS" and "rival" by
                   the growth of the resident set of the process, ours and the rival's.  Not below 1e5 points, where
                   pages and stacks drown it
     simplices     finite ones in our result; then whether the rival has as many: "same", "differs" (a rival whose tie
                   rule or rounding is not ours), "MISMATCH" (a rival that must agree: exit status 1)
     checked       pbw_check's verdict on our result
     --phases adds the time of our phases in the last build of the best sample, and per point: simplices visited by
     point location, sphere tests, sphere tests left to exact arithmetic, simplices created.

   Sphere is the circle in 2D, plane is nearly a line; weighted is uniform points with weights that hide a few.
   Rivals are linked where they are installed (bench.mk): CGAL, CGAL-TBB, TetGen, Qhull.  `bench --help` has the
   options. */
#define _DEFAULT_SOURCE                    /* fork, mmap and getrusage beside strict C99 */

#define PBW_IMPLEMENTATION
#include "../pbw.h"

#include "../tests/inputs.h"
#include "bench.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#ifndef BENCH_FLAGS
#define BENCH_FLAGS "unknown flags"
#endif

enum { BENCH_SIDES = 6, BENCH_REPEATS = 99, BENCH_THREADS = 256 };

/* ------------------------------------------------------------------------------------------ our side --- */

typedef struct bench_job {
    bench_input input;
    pbw_options options;
    pbw_mesh mesh;
    pbw_status status;
} bench_job;

static int bench_fits(const bench_input *input)
{
    (void)input;
    return 1;
}

static void *bench_prepare(const bench_input *input)
{
    bench_job *job = (bench_job *)calloc(1, sizeof *job);
    if (job == NULL) {
        abort();
    }
    job->input = *input;
    job->options.threads = input->threads;
    return job;
}

static void bench_build(void *that)
{
    bench_job *job = (bench_job *)that;
    const bench_input *input = &job->input;
    job->status = pbw_triangulate(input->dim, input->points, input->weights, input->count, &job->options, &job->mesh);
}

static void bench_discard(void *that)
{
    pbw_free(&((bench_job *)that)->mesh);
}

static void bench_report(void *that, bench_sample *sample)
{
    bench_job *job = (bench_job *)that;
    const pbw_statistics *statistics = &job->mesh.statistics;
    pbw_report verdict;

    if (job->status != PBW_OK) {
        snprintf(sample->failure, sizeof sample->failure, "%s", pbw_status_string(job->status));
        return;
    }
    sample->simplices = job->mesh.simplex_count;
    sample->held = statistics->peak_bytes;
    sample->phases[0] = statistics->order_seconds;
    sample->phases[1] = statistics->build_seconds;
    sample->phases[2] = statistics->output_seconds;
    sample->counters[0] = statistics->walk_steps;
    sample->counters[1] = statistics->conflict_tests;
    sample->counters[2] = statistics->exact_tests;
    sample->counters[3] = statistics->created;
    if (!job->input.check) {
        return;
    }
    job->status = pbw_check(&job->mesh, &job->options, &verdict);
    if (job->status != PBW_OK) {
        snprintf(sample->failure, sizeof sample->failure, "check: %s", pbw_status_string(job->status));
    } else if (!verdict.valid) {
        snprintf(sample->failure, sizeof sample->failure, "INVALID: %s", verdict.what);
    } else {
        sample->checked = 1;
    }
}

static const bench_side bench_pbw = {
    "pbw", 1, bench_fits, bench_prepare, bench_build, bench_discard, bench_report
};

static const bench_side *const bench_rivals[] = {
#ifdef BENCH_CGAL
    &bench_cgal,
#endif
#ifdef BENCH_TBB
    &bench_cgal_tbb,
#endif
#ifdef BENCH_TETGEN
    &bench_tetgen,
#endif
#ifdef BENCH_QHULL
    &bench_qhull,
#endif
    NULL
};

/* ------------------------------------------------------------------------------------------- samples --- */

static double bench_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static size_t bench_resident(void)         /* bytes; 0 where there is no /proc */
{
    unsigned long total = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file != NULL) {
        if (fscanf(file, "%lu %lu", &total, &resident) != 2) {
            resident = 0;
        }
        fclose(file);
    }
    return (size_t)resident * (size_t)sysconf(_SC_PAGESIZE);
}

static void bench_measure(const bench_side *side, const bench_input *input, bench_sample *sample)
{
    void *job = side->prepare(input);
    size_t before = bench_resident(), builds = 0;
    struct rusage usage;

    for (;;) {
        double start = bench_now();
        side->build(job);
        sample->seconds += bench_now() - start;
        /* ru_maxrss is in KiB on Linux, and starts anew in a forked process. */
        if (builds++ == 0 && before != 0 && getrusage(RUSAGE_SELF, &usage) == 0) {
            size_t most = (size_t)usage.ru_maxrss * 1024;
            sample->resident = most > before ? most - before : 0;
        }
        if (sample->seconds >= 0.05) {
            break;
        }
        side->discard(job);
    }
    sample->seconds /= (double)builds;
    side->report(job, sample);
    sample->done = 1;
}

/* Memory that returns to the system when it is freed: what this process kept resident in its heap, a forked one would
   reuse, at another price, and its growth would not show.  mode is MAP_PRIVATE, or MAP_SHARED to hear from a forked
   process; shared pages count for its resident set only once it reads them, so the points are private. */
static void *bench_map(size_t bytes, int mode)
{
    void *block = mmap(NULL, bytes, PROT_READ | PROT_WRITE, mode | MAP_ANONYMOUS, -1, 0);
    if (block == MAP_FAILED) {
        perror("bench: no memory");
        exit(2);
    }
    return block;
}

/* Takes a sample in a new process, which an alarm ends if it runs for more than limit seconds. */
static bench_sample bench_sample_of(const bench_side *side, const bench_input *input, unsigned limit)
{
    bench_sample sample, *shared = (bench_sample *)bench_map(sizeof sample, MAP_SHARED);
    int status = 0;
    pid_t child;

    fflush(NULL);
    child = fork();
    if (child < 0) {
        perror("bench: no process for a sample");
        exit(2);
    }
    if (child == 0) {
        alarm(limit);
        bench_measure(side, input, shared);
        _exit(0);
    }
    while (waitpid(child, &status, 0) < 0) {
    }
    sample = *shared;
    munmap(shared, sizeof sample);
    if (!sample.done) {
        if (!WIFSIGNALED(status)) {
            snprintf(sample.failure, sizeof sample.failure, "exit status %d", WEXITSTATUS(status));
        } else if (WTERMSIG(status) == SIGALRM) {
            snprintf(sample.failure, sizeof sample.failure, "over %u s", limit);
        } else {
            snprintf(sample.failure, sizeof sample.failure, "signal %d", WTERMSIG(status));
        }
    }
    return sample;
}

/* ---------------------------------------------------------------------------------------------- rows --- */

typedef struct bench_record {              /* all samples of one side on one input */
    const bench_side *side;
    bench_sample best;                     /* but resident is the most, and checked is whether any was */
    double seconds[BENCH_REPEATS], spent;
    int runs;
} bench_record;

typedef struct bench_settings {
    int repeats, phases, faults;
    unsigned limit;
    double budget;
    FILE *csv;
} bench_settings;

static void bench_add(bench_record *record, const bench_sample *sample)
{
    size_t resident = record->best.resident > sample->resident ? record->best.resident : sample->resident;
    int checked = record->best.checked || sample->checked;

    record->seconds[record->runs++] = sample->seconds;
    record->spent += sample->seconds;
    if (record->runs == 1 || sample->failure[0] != 0 || sample->seconds < record->best.seconds) {
        record->best = *sample;
    }
    record->best.resident = resident;
    record->best.checked = checked;
}

static int bench_compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double bench_median(const bench_record *record)
{
    double sorted[BENCH_REPEATS];
    memcpy(sorted, record->seconds, sizeof sorted);
    qsort(sorted, (size_t)record->runs, sizeof *sorted, bench_compare);
    return 0.5 * (sorted[(record->runs - 1) / 2] + sorted[record->runs / 2]);
}

typedef struct bench_text { char text[16]; } bench_text;

static bench_text bench_time(const bench_record *record, double seconds)
{
    bench_text out = { "-" };
    if (record == NULL || record->best.failure[0] != 0) {
        return out;
    }
    if (seconds < 0.9995e-3) {
        snprintf(out.text, sizeof out.text, "%.3g us", seconds * 1e6);
    } else if (seconds < 0.9995) {
        snprintf(out.text, sizeof out.text, "%.3g ms", seconds * 1e3);
    } else {
        snprintf(out.text, sizeof out.text, seconds < 999 ? "%.3g s" : "%.0f s", seconds);
    }
    return out;
}

static bench_text bench_bytes(size_t bytes, size_t count)
{
    bench_text out = { "-" };
    if (bytes != 0 && count >= 100000) {
        snprintf(out.text, sizeof out.text, "%.0f", (double)bytes / (double)count);
    }
    return out;
}

static void bench_head(const bench_settings *settings)
{
    printf("\n%-11s %3s %8s %3s | %7s %7s | %-8s %7s %7s | %6s %5s | %4s %4s %5s | %9s %-8s | %s", "points", "dim",
           "n", "thr", "pbw", "median", "rival", "best", "median", "ratio", "runs", "B/pt", "RSS", "rival",
           "simplices", "rival", "checked");
    if (settings->phases) {
        printf(" | %7s %7s %7s | %6s %6s %7s %7s", "order", "build", "output", "visits", "tests", "exact", "created");
    }
    printf("\n");
    if (settings->csv != NULL) {
        fprintf(settings->csv,
                "points,dim,n,threads,pbw_best,pbw_median,pbw_runs,rival,rival_best,rival_median,rival_runs,"
                "pbw_held,pbw_resident,rival_resident,pbw_simplices,rival_simplices,checked,pbw_failure,"
                "rival_failure,"
                "order,build,output,walk_steps,conflict_tests,exact_tests,created\n");
    }
}

static void bench_csv(FILE *csv, const char *kind, const bench_input *input, const bench_record *us,
                      const bench_record *rival)
{
    const bench_sample *ours = &us->best;
    int i;
    fprintf(csv, "%s,%d,%lu,%d,%.9g,%.9g,%d,", kind, input->dim, (unsigned long)input->count, input->threads,
            ours->seconds, bench_median(us), us->runs);
    if (rival != NULL) {
        fprintf(csv, "%s,%.9g,%.9g,%d,", rival->side->name, rival->best.seconds, bench_median(rival), rival->runs);
    } else {
        fprintf(csv, ",,,,");
    }
    fprintf(csv, "%lu,%lu,%lu,%lu,%lu,%d,%s,%s", (unsigned long)ours->held, (unsigned long)ours->resident,
            (unsigned long)(rival != NULL ? rival->best.resident : 0), (unsigned long)ours->simplices,
            (unsigned long)(rival != NULL ? rival->best.simplices : 0), ours->checked, ours->failure,
            rival != NULL ? rival->best.failure : "");
    for (i = 0; i < 3; i++) {
        fprintf(csv, ",%.9g", ours->phases[i]);
    }
    for (i = 0; i < 4; i++) {
        fprintf(csv, ",%lu", (unsigned long)ours->counters[i]);
    }
    fprintf(csv, "\n");
    fflush(csv);
}

/* rival NULL: nobody fits. */
static void bench_row(bench_settings *settings, const char *kind, const bench_input *input, const bench_record *us,
                      const bench_record *rival)
{
    const bench_sample *ours = &us->best, *theirs = rival != NULL ? &rival->best : NULL;
    int comparable = rival != NULL && ours->failure[0] == 0 && theirs->failure[0] == 0, mismatch = 0, i;
    const char *agreement = "-";
    double n = (double)input->count;
    bench_text ratio = { "-" }, runs;

    if (comparable) {
        snprintf(ratio.text, sizeof ratio.text, "%.3f", ours->seconds / theirs->seconds);
        mismatch = ours->simplices != theirs->simplices && rival->side->exact;
        agreement = mismatch ? "MISMATCH" : ours->simplices != theirs->simplices ? "differs" : "same";
    }
    snprintf(runs.text, sizeof runs.text, "%d:%d", us->runs, rival != NULL ? rival->runs : 0);
    printf("%-11s %3d %8lu %3d | %7s %7s | %-8s %7s %7s | %6s %5s | %4s %4s %5s | %9lu %-8s | %s", kind, input->dim,
           (unsigned long)input->count, input->threads, bench_time(us, ours->seconds).text,
           bench_time(us, bench_median(us)).text, rival != NULL ? rival->side->name : "-",
           bench_time(rival, rival != NULL ? theirs->seconds : 0).text,
           bench_time(rival, rival != NULL ? bench_median(rival) : 0).text, ratio.text, runs.text,
           bench_bytes(ours->held, input->count).text, bench_bytes(ours->resident, input->count).text,
           bench_bytes(rival != NULL ? theirs->resident : 0, input->count).text, (unsigned long)ours->simplices,
           agreement, ours->failure[0] != 0 ? ours->failure : ours->checked ? "yes" : "no");
    if (settings->phases) {
        printf(" |");
        for (i = 0; i < 3; i++) {
            printf(" %7s", bench_time(us, ours->phases[i]).text);
        }
        printf(" | %6.2f %6.2f %7.4f %7.2f", (double)ours->counters[0] / n, (double)ours->counters[1] / n,
               (double)ours->counters[2] / n, (double)ours->counters[3] / n);
    }
    if (rival != NULL && theirs->failure[0] != 0) {
        printf(" | %s: %s", rival->side->name, theirs->failure);
    }
    printf("\n");
    if (mismatch) {
        printf("*** MISMATCH: pbw has %lu simplices, %s has %lu ***\n", (unsigned long)ours->simplices,
               rival->side->name, (unsigned long)theirs->simplices);
    }
    fflush(stdout);
    settings->faults += mismatch;
    if (settings->csv != NULL) {
        bench_csv(settings->csv, kind, input, us, rival);
    }
}

/* Does list, with commas, have name, or stand for all? */
static int bench_listed(const char *list, const char *name)
{
    size_t length = strlen(name);
    const char *at;
    if (strcmp(list, "all") == 0) {
        return 1;
    }
    for (at = list; (at = strstr(at, name)) != NULL; at += length) {
        if ((at == list || at[-1] == ',') && (at[length] == 0 || at[length] == ',')) {
            return 1;
        }
    }
    return 0;
}

/* All samples of one input and the rows that come of them. */
static void bench_input_rows(bench_settings *settings, const char *kind, bench_input *input, const char *rivals)
{
    bench_record records[BENCH_SIDES];
    int sides = 1, round, i;

    memset(records, 0, sizeof records);
    records[0].side = &bench_pbw;
    for (i = 0; bench_rivals[i] != NULL; i++) {
        if (bench_listed(rivals, bench_rivals[i]->name) && bench_rivals[i]->fits(input)) {
            records[sides++].side = bench_rivals[i];
        }
    }
    for (round = 0; round < settings->repeats; round++) {
        for (i = 0; i < sides; i++) {
            if (round == 0 || (records[i].spent < settings->budget && records[i].best.failure[0] == 0)) {
                bench_sample sample;
                input->check = round == 0;
                sample = bench_sample_of(records[i].side, input, settings->limit);
                bench_add(&records[i], &sample);
            }
        }
    }
    settings->faults += records[0].best.failure[0] != 0;
    for (i = 1; i < sides; i++) {
        bench_row(settings, kind, input, &records[0], &records[i]);
    }
    if (sides == 1) {
        bench_row(settings, kind, input, &records[0], NULL);
    }
}

/* --------------------------------------------------------------------------------------------- plans --- */

static const struct bench_kind {
    const char *name;
    int points, weights;                   /* weights -1: none */
} bench_kinds[] = {
    { "uniform", INPUT_UNIFORM, -1 },
    { "gauss", INPUT_GAUSS, -1 },
    { "ball", INPUT_BALL, -1 },
    { "sphere", INPUT_SPHERE, -1 },
    { "clusters", INPUT_CLUSTERS, -1 },
    { "lattice", INPUT_LATTICE, -1 },
    { "lines", INPUT_LINES, -1 },
    { "spiral", INPUT_SPIRAL, -1 },
    { "plane", INPUT_PLANE, -1 },
    { "anisotropic", INPUT_ANISOTROPIC, -1 },
    { "weighted", INPUT_UNIFORM, INPUT_WEIGHTS_HIDING }
};

/* A line means the product of its lists.  "all" kinds or rivals: every one; "others": all kinds but the first;
   "all" threads: 1, 2, 4, ... and the number of cores; "most": the number of cores.  A rival makes a row only where
   it fits: TetGen in 3D, CGAL-TBB in 3D on several threads, and so on. */
typedef struct bench_plan {
    const char *mode, *dims, *kinds, *sizes, *threads, *rivals;
} bench_plan;

static const bench_plan bench_plans[] = {
    { "quick", "3", "uniform", "100,1000,1e4", "1", "all" },
    { "quick", "3", "uniform", "1e5", "all", "all" },
    { "quick", "3", "others", "1e5", "1", "CGAL" },
    { "quick", "2", "uniform", "100,1000,1e4", "1", "all" },
    { "quick", "2", "uniform", "1e5", "all", "all" },
    { "quick", "2", "others", "1e5", "1", "CGAL" },
    { "default", "3", "uniform", "100,1000,1e4,1e5", "1", "all" },
    { "default", "3", "uniform", "1e6", "all", "all" },
    { "default", "3", "others", "1e6", "1,most", "CGAL,CGAL-TBB" },
    { "default", "2", "uniform", "100,1000,1e4,1e5", "1", "all" },
    { "default", "2", "uniform", "1e6", "all", "all" },
    { "default", "2", "others", "1e6", "1", "CGAL" },
    { "full", "2,3", "all", "100,1000,1e4,1e5,1e6", "all", "all" },
    { "full", "2,3", "uniform", "1e7", "all", "all" },
    { "full", "2,3", "others", "1e7", "1,most", "CGAL,CGAL-TBB" }
};

static int bench_cores(void)
{
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    return cores < 1 ? 1 : cores > BENCH_THREADS ? BENCH_THREADS : (int)cores;
}

/* Takes the next item from a list with commas; 0 at its end. */
static int bench_next(const char **list, char item[32])
{
    size_t length = strcspn(*list, ",");
    snprintf(item, 32, "%.*s", (int)length, *list);
    *list += length + ((*list)[length] == ',');
    return length != 0;
}

static size_t bench_number(const char *item)                 /* 0 if it is none */
{
    double value = strtod(item, NULL);
    return value >= 1 && value < 4e9 ? (size_t)value : 0;
}

static void bench_threads(bench_settings *settings, const char *kind, bench_input *input, const bench_plan *plan)
{
    const char *rest = plan->threads;
    int cores = bench_cores(), done = 0;
    char item[32];
    while (bench_next(&rest, item)) {
        if (strcmp(item, "all") == 0) {
            for (input->threads = 1; input->threads < cores; input->threads *= 2) {
                bench_input_rows(settings, kind, input, plan->rivals);
            }
            input->threads = cores;
        } else {
            input->threads = strcmp(item, "most") == 0 ? cores : (int)bench_number(item);
        }
        if (input->threads != done) {                        /* "1,most" on one core is one row */
            bench_input_rows(settings, kind, input, plan->rivals);
        }
        done = input->threads;
    }
}

/* Makes the points and their rows. */
static void bench_points(bench_settings *settings, const struct bench_kind *kind, size_t dim, size_t count,
                         const bench_plan *plan)
{
    double *points = (double *)bench_map(count * dim * sizeof(double), MAP_PRIVATE);
    double *weights = (double *)bench_map(count * sizeof(double), MAP_PRIVATE);
    bench_input input;
    memset(&input, 0, sizeof input);
    input.dim = (int)dim;
    input.count = count;
    input.points = points;
    input_fill(kind->points, (int)dim, count, 1, points);
    if (kind->weights >= 0) {
        input_fill_weights(kind->weights, (int)dim, count, 1, points, weights);
        input.weights = weights;
    }
    bench_threads(settings, kind->name, &input, plan);
    munmap(points, count * dim * sizeof(double));
    munmap(weights, count * sizeof(double));
}

static void bench_follow(bench_settings *settings, const bench_plan *plan)
{
    const size_t kinds = sizeof bench_kinds / sizeof *bench_kinds;
    const char *dims = plan->dims, *sizes;
    char dim[32], size[32];
    size_t i;
    while (bench_next(&dims, dim)) {
        for (i = strcmp(plan->kinds, "others") == 0; i < kinds; i++) {
            if (strcmp(plan->kinds, "others") != 0 && !bench_listed(plan->kinds, bench_kinds[i].name)) {
                continue;
            }
            for (sizes = plan->sizes; bench_next(&sizes, size);) {
                bench_points(settings, &bench_kinds[i], bench_number(dim), bench_number(size), plan);
            }
        }
    }
}

/* What of a plan of the user's own cannot be followed; NULL if nothing. */
static const char *bench_fault(const bench_plan *plan)
{
    const size_t kinds = sizeof bench_kinds / sizeof *bench_kinds;
    const char *rest;
    char item[32];
    size_t i;
    for (rest = plan->dims; bench_next(&rest, item);) {
        if (strcmp(item, "2") != 0 && strcmp(item, "3") != 0) {
            return "the dimension must be 2 or 3";
        }
    }
    for (rest = plan->sizes; bench_next(&rest, item);) {
        if (bench_number(item) < 4) {
            return "a size must be a number, 4 or more";
        }
    }
    for (rest = plan->threads; bench_next(&rest, item);) {
        i = bench_number(item);
        if ((i < 1 || i > BENCH_THREADS) && strcmp(item, "all") != 0 && strcmp(item, "most") != 0) {
            return "threads must be numbers from 1 to 256, all or most";
        }
    }
    for (rest = plan->kinds; bench_next(&rest, item);) {
        for (i = 0; i < kinds && strcmp(item, bench_kinds[i].name) != 0; i++) {
        }
        if (i == kinds && strcmp(item, "all") != 0 && strcmp(item, "others") != 0) {
            return "a kind of points is unknown";
        }
    }
    for (rest = plan->rivals; bench_next(&rest, item);) {
        for (i = 0; bench_rivals[i] != NULL && strcmp(item, bench_rivals[i]->name) != 0; i++) {
        }
        if (bench_rivals[i] == NULL && strcmp(item, "all") != 0 && strcmp(item, "none") != 0) {
            return "a rival is unknown or not installed";
        }
    }
    return NULL;
}

/* ---------------------------------------------------------------------------------------------- main --- */

static const char bench_usage[] =
    "usage: bench [--quick | --full] [options]\n"
    "  --quick             a minute, up to 1e5 points;  --full: hours, up to 1e7;  else ten minutes, up to 1e6\n"
    "  --dim 2,3           any of these five replaces the plan by the product of the five\n"
    "  --kinds LIST        uniform, gauss, ball, sphere, clusters, lattice, lines, spiral, plane, anisotropic,\n"
    "                      weighted; all; others: all but uniform\n"
    "  --sizes LIST        such as 1000,1e6\n"
    "  --threads LIST      such as 1,4; all: 1, 2, 4, ... and the number of cores; most: only that\n"
    "  --rivals LIST       CGAL, CGAL-TBB, TetGen, Qhull; all; none\n"
    "  --phases            adds our phases and counters\n"
    "  --csv FILE          also writes the rows there, in seconds and bytes\n"
    "  --repeats N         most samples of a side (7)\n"
    "  --budget SECONDS    of a side, after which it takes no further sample (1 quick, 6, 20 full)\n"
    "  --limit SECONDS     ends a single sample (300)\n";

static void bench_machine(void)
{
    char line[256], model[200] = "unknown processor";
    double load[3] = { 0, 0, 0 };
    FILE *file = fopen("/proc/cpuinfo", "r");
    int i;
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        if (sscanf(line, "model name : %199[^\n]", model) == 1) {
            break;
        }
    }
    if (file != NULL) {
        fclose(file);
    }
    if (getloadavg(load, 3) < 1) {
        load[0] = -1;
    }
    printf("pbw %d.%d.%d, %s, %d cores, load %.2f before the start\n", PBW_VERSION_MAJOR, PBW_VERSION_MINOR,
           PBW_VERSION_PATCH, model, bench_cores(), load[0]);
#ifdef __VERSION__
    printf("compiler %s, %s\n", __VERSION__, BENCH_FLAGS);
#endif
    printf("rivals:");
    for (i = 0; bench_rivals[i] != NULL; i++) {
        printf(" %s", bench_rivals[i]->name);
    }
    printf("%s\n", i == 0 ? " none installed" : "");
}

static int bench_fail(const char *what)
{
    fprintf(stderr, "bench: %s\n%s", what, bench_usage);
    return 2;
}

int main(int argc, char **argv)
{
    bench_settings settings = { 7, 0, 0, 300, 0, NULL };
    bench_plan own = { NULL, NULL, NULL, NULL, NULL, NULL };
    const char *mode = "default";
    size_t p;
    int i;

    for (i = 1; i < argc; i++) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (strcmp(name, "--quick") == 0 || strcmp(name, "--full") == 0) {
            mode = name + 2;
            continue;
        }
        if (strcmp(name, "--phases") == 0) {
            settings.phases = 1;
            continue;
        }
        if (strcmp(name, "--help") == 0) {
            fputs(bench_usage, stdout);
            return 0;
        }
        if (value == NULL) {
            return bench_fail("an option is unknown or lacks its value");
        }
        i++;
        if (strcmp(name, "--dim") == 0) {
            own.dims = value;
        } else if (strcmp(name, "--kinds") == 0) {
            own.kinds = value;
        } else if (strcmp(name, "--sizes") == 0) {
            own.sizes = value;
        } else if (strcmp(name, "--threads") == 0) {
            own.threads = value;
        } else if (strcmp(name, "--rivals") == 0) {
            own.rivals = value;
        } else if (strcmp(name, "--csv") == 0) {
            settings.csv = fopen(value, "w");
            if (settings.csv == NULL) {
                return bench_fail("the CSV file cannot be written");
            }
        } else if (strcmp(name, "--repeats") == 0) {
            settings.repeats = atoi(value);
        } else if (strcmp(name, "--budget") == 0) {
            settings.budget = atof(value);
        } else if (strcmp(name, "--limit") == 0) {
            settings.limit = (unsigned)atoi(value);
        } else {
            return bench_fail("unknown option");
        }
    }
    if (settings.repeats < 1 || settings.repeats > BENCH_REPEATS) {
        return bench_fail("repeats must be 1 to 99");
    }
    if (settings.budget <= 0) {
        settings.budget = strcmp(mode, "quick") == 0 ? 1 : strcmp(mode, "full") == 0 ? 20 : 6;
    }
    bench_machine();
    if (own.dims != NULL || own.kinds != NULL || own.sizes != NULL || own.threads != NULL || own.rivals != NULL) {
        own.dims = own.dims != NULL ? own.dims : "3,2";
        own.kinds = own.kinds != NULL ? own.kinds : "all";
        own.threads = own.threads != NULL ? own.threads : "1";
        own.rivals = own.rivals != NULL ? own.rivals : "all";
        if (own.sizes == NULL) {
            own.sizes = strcmp(mode, "quick") == 0 ? "1e5" : strcmp(mode, "full") == 0 ? "1e7" : "1e6";
        }
        if (bench_fault(&own) != NULL) {
            return bench_fail(bench_fault(&own));
        }
        bench_head(&settings);
        bench_follow(&settings, &own);
    } else {
        bench_head(&settings);
        for (p = 0; p < sizeof bench_plans / sizeof *bench_plans; p++) {
            if (strcmp(bench_plans[p].mode, mode) == 0) {
                bench_follow(&settings, &bench_plans[p]);
            }
        }
    }
    if (settings.csv != NULL) {
        fclose(settings.csv);
    }
    if (settings.faults != 0) {
        printf("\n%d FAULTS: results of ours that failed, or counts that an exact rival contradicts\n",
               settings.faults);
    }
    return settings.faults != 0;
}
