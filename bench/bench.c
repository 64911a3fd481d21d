/* bench.c: pbw and its rivals on the same points, in one table; pbw on 1, 2, 4, ... threads, in another

   METHOD
     Every sample is taken in a process of its own, forked from this one after the points have been made, so all
     start with the same cold heap and none gains or suffers from what ran before.  Before it, memory that the system
     has to get from elsewhere is got, and left free: see bench_wake_memory.  Timed is the way from points in
     memory to the triangulation in memory; turning the points into the form that a library takes, and freeing, are
     not.  Builds of less than 50 ms are repeated, one after the other, until 50 ms are over, and the sample is their
     mean.  Of at most 1000 points there are 64 sets, each with a seed of its own, that take turns: a processor learns
     the branches of a short build that it sees again and again (CGAL then takes a third of the time for 100 points in
     the plane), and programs that triangulate few points often do not triangulate the same ones.
     The sides of a table (pbw and its rivals, or pbw on so many threads) take turns, one sample each, until a side
     has --repeats samples or has used up --budget seconds: a busy machine slows all alike.  Where threads are compared
     each side has two of them whatever they cost: a first one alone may be slow, and flatters what is compared with
     it.  Do not read anything into gaps under a tenth, and look at the load that the first lines report.
     In the first round pbw_check judges our result, exactly, after the clock has stopped; all our results on the same
     points must have the same pbw_hash.

   RIVALS
     thr           threads of both sides; but CGAL has one in 2D, whatever we have
     pbw, rival    the best sample; the median
     ratio         our best / the rival's best: below 1 we are faster
     must          what bench_musts asks of the column before it, and "yes" or "NO"
     runs          samples, ours:the rival's
     B/pt          bytes per point above the input at the peak: ours by the library's own count; "RSS" and "rival" by
                   the growth of the resident set of the process, ours and the rival's.  Not below 1e5 points, where
                   pages and stacks drown it
     simplices     finite ones in our result; then whether the rival has as many: "same", "differs" (a rival whose tie
                   rule or rounding is not ours), "MISMATCH" (a rival that must agree: exit status 1)
     checked       pbw_check's verdict on our result
     --phases adds the time of our phases in the best sample; where bench was made with BENCH_CLOCKS also that of
     the parts of the build, which it makes slower by some hundredths; and per point: simplices visited by point
     location, sphere tests, sphere tests left to exact arithmetic, simplices created.

   THREADS
     speed-up      our best on one thread / our best here; effic. = speed-up / threads
     rounds, later, serial    of the best sample, as in pbw_statistics; the last two in a thousand points
     bytes         "same": the hash is that on one thread

   Musts are goals: a missed one is no failure.  Rivals are linked where they are installed (bench.mk): CGAL,
   CGAL-TBB, TetGen, Qhull.  `bench --help` has the options. */
#define _DEFAULT_SOURCE                    /* fork, mmap and getrusage beside strict C99 */

#include <stdint.h>
#include <time.h>

#ifdef BENCH_CLOCKS                        /* make bench PHASES=1: five readings of a clock for each insertion */
static __thread uint64_t bench_ticks[5], bench_since;        /* by phase; those of the caller's thread are shown */
static __thread int bench_phase;
static uint64_t bench_clock(void)
{
#ifdef __x86_64__
    return __builtin_ia32_rdtsc();
#else
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
#endif
}
static void bench_turn_to(int phase)
{
    uint64_t now = bench_clock();
    bench_ticks[bench_phase] += now - bench_since;
    bench_since = now;
    bench_phase = phase;
}
#define PBW__PHASE(phase) bench_turn_to(phase)
#endif

#define PBW_IMPLEMENTATION
#define PBW_CHECK_IMPLEMENTATION
#include "pbw_check.h"

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

enum {
    BENCH_SIDES = 10,                      /* 1, 2, 4, ... 256, and the cores */
    BENCH_REPEATS = 99,
    BENCH_THREADS = 256,
    BENCH_SETS = 64
};

/* ------------------------------------------------------------------------------------------ our side --- */

typedef struct bench_job {
    bench_input input;
    pbw_options options;
    pbw_mesh mesh;
    pbw_status status;
    uint64_t ticks;                        /* of the clock of phases, in so many seconds */
    double seconds;
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
#ifdef BENCH_CLOCKS
    memset(bench_ticks, 0, sizeof bench_ticks);
    bench_phase = PBW__OTHER;
    bench_since = bench_clock();
    job->ticks = bench_since;
    job->seconds = pbw__seconds();
#endif
    job->status = pbw_triangulate(input->dim, input->points, input->weights, input->count, &job->options, &job->mesh);
#ifdef BENCH_CLOCKS
    job->ticks = bench_clock() - job->ticks;
    job->seconds = pbw__seconds() - job->seconds;
#endif
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
#ifdef BENCH_CLOCKS
    int i;
#endif

    if (job->status != PBW_OK) {
        snprintf(sample->failure, sizeof sample->failure, "%s", pbw_status_string(job->status));
        return;
    }
    sample->simplices = job->mesh.simplex_count;
    sample->held = statistics->peak_bytes;
    sample->hash = pbw_hash(&job->mesh, NULL);
    sample->phases[0] = statistics->order_seconds;
    sample->phases[1] = statistics->build_seconds;
    sample->phases[2] = statistics->output_seconds;
#ifdef BENCH_CLOCKS
    for (i = 0; i < 4; i++) {
        sample->phases[3 + i] = (double)bench_ticks[i] * job->seconds / (double)job->ticks;
    }
#endif
    sample->counters[0] = statistics->walk_steps;
    sample->counters[1] = statistics->conflict_tests;
    sample->counters[2] = statistics->exact_tests;
    sample->counters[3] = statistics->created;
    sample->counters[4] = statistics->rounds;
    sample->counters[5] = statistics->postponed;
    sample->counters[6] = statistics->serial;
    if (!job->input.check) {
        return;
    }
    job->options.threads = 0;
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
    void *jobs[BENCH_SETS];
    size_t before, builds = 0, i;
    struct rusage usage;

    for (i = 0; i < input->sets; i++) {
        bench_input set = *input;
        set.points += i * input->count * (size_t)input->dim;
        set.weights = input->weights != NULL ? input->weights + i * input->count : NULL;
        jobs[i] = side->prepare(&set);
    }
    before = bench_resident();
    for (;;) {
        void *job = jobs[builds % input->sets];
        double start = bench_now();
        side->build(job);
        sample->seconds += bench_now() - start;
        /* ru_maxrss is in KiB on Linux, and starts from 0 in a forked process. */
        if (builds++ == 0 && before != 0 && getrusage(RUSAGE_SELF, &usage) == 0) {
            size_t most = (size_t)usage.ru_maxrss * 1024;
            sample->resident = most > before ? most - before : 0;
        }
        if (sample->seconds >= 0.05 && builds % input->sets == 0) {
            break;
        }
        side->discard(job);
    }
    sample->seconds /= (double)builds;
    if (input->sets > 1) {                 /* the last build was not of the points that are reported */
        side->discard(jobs[input->sets - 1]);
        side->build(jobs[0]);
    }
    side->report(jobs[0], sample);
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

static void bench_wait_for(pid_t child, int *status)
{
    while (waitpid(child, status, 0) < 0) {
    }
}

/* The system of a virtual machine may return memory that lies free for some seconds to its host, which hands it back
   page by page at the next touch, at 10 us each: half a second or more for a million points, in the sample of whichever
   side comes after a pause or after a side that needs little.  So a process touches as much as our largest build may
   take (300 or 110 bytes a point), in large pages where they are to be had, and leaves it warm for the next one. */
static void bench_wake_memory(const bench_input *input)
{
    size_t bytes = input->count * (input->dim == 3 ? 300 : 110), i;
    int status;
    pid_t child = fork();
    if (child == 0) {
        char *block = (char *)bench_map(bytes, MAP_PRIVATE);
#ifdef MADV_HUGEPAGE
        (void)madvise(block, bytes, MADV_HUGEPAGE);
#endif
        for (i = 0; i < bytes; i += 4096) {
            block[i] = 1;
        }
        _exit(0);
    }
    if (child > 0) {
        bench_wait_for(child, &status);
    }
}

/* Takes a sample in a new process, which an alarm ends if it runs for more than limit seconds. */
static bench_sample bench_sample_of(const bench_side *side, const bench_input *input, unsigned limit)
{
    bench_sample sample, *shared = (bench_sample *)bench_map(sizeof sample, MAP_SHARED);
    int status = 0;
    pid_t child;

    fflush(NULL);
    bench_wake_memory(input);
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
    bench_wait_for(child, &status);
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

/* --------------------------------------------------------------------------------------------- musts --- */

/* In names: 2D, 3D; weights -1: none. */
static const struct bench_kind {
    const char *names[2];
    int points, weights;
} bench_kinds[] = {
    { { "uniform", "uniform" }, INPUT_UNIFORM, -1 },
    { { "gauss", "gauss" }, INPUT_GAUSS, -1 },
    { { "ball", "ball" }, INPUT_BALL, -1 },
    { { "circle", "sphere" }, INPUT_SPHERE, -1 },
    { { "clusters", "clusters" }, INPUT_CLUSTERS, -1 },
    { { "lattice", "lattice" }, INPUT_LATTICE, -1 },
    { { "lines", "lines" }, INPUT_LINES, -1 },
    { { "spiral", "spiral" }, INPUT_SPIRAL, -1 },
    { { "near-collinear", "near-planar" }, INPUT_PLANE, -1 },
    { { "anisotropic", "anisotropic" }, INPUT_ANISOTROPIC, -1 },
    { { "terrain", "terrain" }, INPUT_TERRAIN, -1 },
    { { "weighted", "weighted" }, INPUT_UNIFORM, INPUT_WEIGHTS_HIDING }
};

enum bench_goal { BENCH_RATIO, BENCH_BYTES, BENCH_SPEEDUP, BENCH_SECONDS };

/* The numbers that pbw is to reach; the first row that fits counts.  Ratios are to CGAL on one thread, bytes a point
   by the library's own count; seconds on 4 threads are a third of those of the best rival on those points, measured
   on a like machine. */
static const struct bench_must {
    enum bench_goal goal;
    int dim;
    const char *kinds;
    double count;
    int threads;
    double value;
} bench_musts[] = {
    { BENCH_RATIO, 3, "uniform", 100, 1, 0.25 },
    { BENCH_RATIO, 3, "uniform", 1000, 1, 0.3 },
    { BENCH_RATIO, 3, "uniform", 1e4, 1, 0.27 },
    { BENCH_RATIO, 2, "uniform", 100, 1, 0.6 },
    { BENCH_RATIO, 2, "uniform", 1000, 1, 0.4 },
    { BENCH_RATIO, 3, "uniform", 1e6, 1, 0.28 },
    { BENCH_RATIO, 3, "uniform", 1e7, 1, 0.28 },
    { BENCH_RATIO, 3, "weighted", 1e6, 1, 0.33 },
    { BENCH_RATIO, 3, "lattice,clusters,lines,spiral,anisotropic,near-planar,gauss,ball", 1e6, 1, 0.35 },
    { BENCH_RATIO, 3, "sphere", 1e6, 1, 0.4 },
    { BENCH_RATIO, 2, "uniform", 1e6, 1, 0.45 },
    { BENCH_RATIO, 2, "gauss,circle,lattice,lines,near-collinear,anisotropic", 1e6, 1, 0.5 },
    { BENCH_BYTES, 3, "all", 1e6, 1, 300 },
    { BENCH_BYTES, 2, "all", 1e6, 1, 110 },
    { BENCH_BYTES, 3, "all", 1e7, 1, 300 },
    { BENCH_BYTES, 2, "all", 1e7, 1, 110 },
    { BENCH_SPEEDUP, 3, "uniform", 1e6, 4, 3.2 },
    { BENCH_SPEEDUP, 3, "uniform", 1e7, 4, 3.2 },
    { BENCH_SPEEDUP, 2, "uniform", 1e6, 4, 3.0 },
    { BENCH_SPEEDUP, 2, "uniform", 1e7, 4, 3.0 },
    { BENCH_SPEEDUP, 3, "all", 1e6, 4, 2.6 },
    { BENCH_SPEEDUP, 2, "all", 1e6, 4, 2.6 },
    { BENCH_SPEEDUP, 3, "uniform", 1e6, 16, 10 },
    { BENCH_SPEEDUP, 3, "uniform", 1e7, 16, 12 },
    { BENCH_SECONDS, 3, "uniform", 1e3, 1, 2e-3 },
    { BENCH_SECONDS, 3, "uniform", 1e6, 4, 1.19 / 3 },
    { BENCH_SECONDS, 3, "gauss", 1e6, 4, 2.12 / 3 },
    { BENCH_SECONDS, 3, "ball", 1e6, 4, 1.38 / 3 },
    { BENCH_SECONDS, 3, "anisotropic", 1e6, 4, 1.46 / 3 },
    { BENCH_SECONDS, 3, "near-planar", 1e6, 4, 1.64 / 3 },
    { BENCH_SECONDS, 3, "clusters", 1e6, 4, 3.05 / 3 },
    { BENCH_SECONDS, 3, "lines", 1e6, 4, 2.90 / 3 },
    { BENCH_SECONDS, 3, "spiral", 1e6, 4, 2.55 / 3 },
    { BENCH_SECONDS, 3, "lattice", 1e6, 4, 3.70 / 3 },
    { BENCH_SECONDS, 3, "sphere", 1e6, 4, 14.3 / 3 },
    { BENCH_SECONDS, 3, "sphere", 2e5, 16, 0.15 },
    { BENCH_SECONDS, 3, "uniform", 1e7, 16, 1.2 }
};

typedef struct bench_text { char text[32]; } bench_text;

static bench_text bench_time(double seconds)
{
    bench_text out;
    if (seconds < 0.9995e-3) {
        snprintf(out.text, sizeof out.text, "%.3g us", seconds * 1e6);
    } else if (seconds < 0.9995) {
        snprintf(out.text, sizeof out.text, "%.3g ms", seconds * 1e3);
    } else {
        snprintf(out.text, sizeof out.text, seconds < 999 ? "%.3g s" : "%.0f s", seconds);
    }
    return out;
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

typedef struct bench_settings {
    int repeats, sets, phases, faults, met, missed;
    unsigned limit;
    double budget;
    FILE *csv;
} bench_settings;

/* The must and whether the value meets it; "-" if there is none. */
static bench_text bench_judge(bench_settings *settings, enum bench_goal goal, const char *kind,
                              const bench_input *input, double value)
{
    bench_text out = { "-" };
    size_t i;
    for (i = 0; i < sizeof bench_musts / sizeof *bench_musts; i++) {
        const struct bench_must *must = bench_musts + i;
        if (must->goal == goal && must->dim == input->dim && bench_listed(must->kinds, kind)
            && must->count == (double)input->count && must->threads == input->threads) {
            int met = goal == BENCH_SPEEDUP ? value >= must->value : value <= must->value;
            const char *verdict = met ? "yes" : "NO";
            if (goal == BENCH_SECONDS) {
                snprintf(out.text, sizeof out.text, "%.3g s %s", must->value, verdict);
            } else {
                snprintf(out.text, sizeof out.text, "%.3g %s", must->value, verdict);
            }
            settings->met += met;
            settings->missed += !met;
            break;
        }
    }
    return out;
}

/* ---------------------------------------------------------------------------------------------- rows --- */

typedef struct bench_record {              /* all samples of one side on one input */
    const bench_side *side;
    bench_input input;
    bench_sample best;                     /* but resident is the most, and checked is whether any was */
    double seconds[BENCH_REPEATS], spent;
    int runs;
} bench_record;

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

static void bench_csv(FILE *csv, const char *kind, const bench_record *record)
{
    const bench_sample *best = &record->best;
    int i;
    fprintf(csv, "%s,%d,%lu,%d,%s,%.9g,%.9g,%d,%lu,%lu,%lu,%d,%016llx,%s", kind, record->input.dim,
            (unsigned long)record->input.count, record->input.threads, record->side->name, best->seconds,
            bench_median(record), record->runs, (unsigned long)best->held, (unsigned long)best->resident,
            (unsigned long)best->simplices, best->checked, (unsigned long long)best->hash, best->failure);
    for (i = 0; i < 7; i++) {
        fprintf(csv, ",%.9g", best->phases[i]);
    }
    for (i = 0; i < 7; i++) {
        fprintf(csv, ",%lu", (unsigned long)best->counters[i]);
    }
    fprintf(csv, "\n");
    fflush(csv);
}

/* All samples, the first `least` of a side whatever they cost; then a line each in the CSV file.  The first side is
   ours, and so is its hash. */
static void bench_take_turns(bench_settings *settings, const char *kind, bench_record *records, int sides, int least)
{
    int round, i;
    for (round = 0; round < settings->repeats; round++) {
        for (i = 0; i < sides; i++) {
            if (records[i].best.failure[0] == 0 && (round < least || records[i].spent < settings->budget)) {
                bench_sample sample;
                records[i].input.check = round == 0 && i == 0;
                sample = bench_sample_of(records[i].side, &records[i].input, settings->limit);
                if (sample.failure[0] == 0 && sample.hash != 0 && records[0].best.failure[0] == 0
                    && records[0].runs > 0 && sample.hash != records[0].best.hash) {
                    snprintf(sample.failure, sizeof sample.failure, "DIFFERENT: not the hash of the first sample");
                }
                bench_add(&records[i], &sample);
            }
        }
    }
    for (i = 0; i < sides; i++) {
        settings->faults += records[i].side == &bench_pbw && records[i].best.failure[0] != 0;
        if (settings->csv != NULL) {
            bench_csv(settings->csv, kind, &records[i]);
        }
    }
}

static bench_text bench_cell(const bench_record *record, double seconds)
{
    bench_text none = { "-" };
    return record == NULL || record->best.failure[0] != 0 ? none : bench_time(seconds);
}

static bench_text bench_bytes(size_t bytes, size_t count)
{
    bench_text out = { "-" };
    if (bytes != 0 && count >= 100000) {
        snprintf(out.text, sizeof out.text, "%.0f", (double)bytes / (double)count);
    }
    return out;
}

static void bench_phases(const bench_record *us)
{
    double n = (double)us->input.count;
    int i;
    printf(" |");
    for (i = 0; i < 7; i++) {
        printf(" %7s", bench_cell(us, us->best.phases[i]).text);
    }
    printf(" |");
    for (i = 0; i < 4; i++) {
        printf(" %7.3f", (double)us->best.counters[i] / n);
    }
}

static void bench_head(const bench_settings *settings, int sweep)
{
    if (sweep) {
        printf("\n%-14s %3s %8s %3s | %7s %7s %12s %5s | %8s %-8s %6s | %6s %7s %7s | %-7s", "points", "dim", "n",
               "thr", "pbw", "median", "must", "runs", "speed-up", "must", "effic.", "rounds", "later", "serial",
               "bytes");
    } else {
        printf("\n%-14s %3s %8s %3s | %7s %7s %11s | %-8s %7s %7s | %5s %-8s %5s | %4s %-7s %4s %5s | %9s %-8s"
               " | %-7s", "points", "dim", "n", "thr", "pbw", "median", "must", "rival", "best", "median", "ratio",
               "must", "runs", "B/pt", "must", "RSS", "rival", "simplices", "rival", "checked");
    }
    if (settings->phases) {
        printf(" | %7s %7s %7s %7s %7s %7s %7s | %7s %7s %7s %7s", "order", "build", "output", "walk", "cavity", "star",
               "exact", "visits", "tests", "exact", "created");
    }
    printf("\n");
}

/* rival NULL: nobody fits.  The musts that do not depend on a rival are those of the first row. */
static void bench_row(bench_settings *settings, const char *kind, const bench_record *us, const bench_record *rival,
                      int first)
{
    const bench_input *input = &us->input;
    const bench_sample *ours = &us->best, *theirs = rival != NULL ? &rival->best : NULL;
    int well = ours->failure[0] == 0, comparable = well && rival != NULL && theirs->failure[0] == 0, mismatch = 0;
    const char *agreement = "-";
    const bench_text none = { "-" };
    bench_text ratio = none, must = none, seconds = none, bytes = none, runs;

    if (comparable) {
        snprintf(ratio.text, sizeof ratio.text, "%.3f", ours->seconds / theirs->seconds);
        mismatch = ours->simplices != theirs->simplices && rival->side->exact;
        agreement = mismatch ? "MISMATCH" : ours->simplices != theirs->simplices ? "differs" : "same";
        if (strcmp(rival->side->name, "CGAL") == 0) {
            must = bench_judge(settings, BENCH_RATIO, kind, input, ours->seconds / theirs->seconds);
        }
    }
    if (well && first && input->threads == 1) {              /* a sweep has the musts of more threads */
        seconds = bench_judge(settings, BENCH_SECONDS, kind, input, ours->seconds);
        bytes = bench_judge(settings, BENCH_BYTES, kind, input, (double)ours->held / (double)input->count);
    }
    snprintf(runs.text, sizeof runs.text, "%d:%d", us->runs, rival != NULL ? rival->runs : 0);
    printf("%-14s %3d %8lu %3d | %7s %7s %11s | %-8s %7s %7s | %5s %-8s %5s | %4s %-7s %4s %5s | %9lu %-8s | %-7s",
           kind, input->dim, (unsigned long)input->count, input->threads, bench_cell(us, ours->seconds).text,
           bench_cell(us, bench_median(us)).text, seconds.text, rival != NULL ? rival->side->name : "-",
           bench_cell(rival, rival != NULL ? theirs->seconds : 0).text,
           bench_cell(rival, rival != NULL ? bench_median(rival) : 0).text, ratio.text, must.text, runs.text,
           bench_bytes(ours->held, input->count).text, bytes.text, bench_bytes(ours->resident, input->count).text,
           bench_bytes(rival != NULL ? theirs->resident : 0, input->count).text, (unsigned long)ours->simplices,
           agreement, !well ? ours->failure : ours->checked ? "yes" : "no");
    if (settings->phases) {
        bench_phases(us);
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
}

static void bench_rows(bench_settings *settings, const char *kind, const bench_input *input, const char *rivals)
{
    bench_record records[BENCH_SIDES];
    int sides = 1, i;

    memset(records, 0, sizeof records);
    records[0].side = &bench_pbw;
    for (i = 0; bench_rivals[i] != NULL; i++) {
        if (bench_listed(rivals, bench_rivals[i]->name) && bench_rivals[i]->fits(input)) {
            records[sides++].side = bench_rivals[i];
        }
    }
    for (i = 0; i < sides; i++) {
        records[i].input = *input;
    }
    bench_take_turns(settings, kind, records, sides, 1);
    for (i = 1; i < sides; i++) {
        bench_row(settings, kind, &records[0], &records[i], i == 1);
    }
    if (sides == 1) {
        bench_row(settings, kind, &records[0], NULL, 1);
    }
}

static void bench_sweep(bench_settings *settings, const char *kind, const bench_input *input, const int *threads,
                        int sides)
{
    bench_record records[BENCH_SIDES];
    int i;

    memset(records, 0, sizeof records);
    for (i = 0; i < sides; i++) {
        records[i].side = &bench_pbw;
        records[i].input = *input;
        records[i].input.threads = threads[i];
    }
    bench_take_turns(settings, kind, records, sides, 2);
    for (i = 0; i < sides; i++) {
        const bench_record *us = &records[i];
        const bench_sample *ours = &us->best;
        const bench_text none = { "-" };
        int well = ours->failure[0] == 0 && records[0].best.failure[0] == 0;
        double speedup = well ? records[0].best.seconds / ours->seconds : 0;
        double thousand = (double)input->count / 1000;
        bench_text seconds = well ? bench_judge(settings, BENCH_SECONDS, kind, &us->input, ours->seconds) : none;
        bench_text must = well ? bench_judge(settings, BENCH_SPEEDUP, kind, &us->input, speedup) : none;
        printf("%-14s %3d %8lu %3d | %7s %7s %12s %5d | %8.2f %-8s %6.2f | %6lu %7.2f %7.2f | %-7s", kind, input->dim,
               (unsigned long)input->count, threads[i], bench_cell(us, ours->seconds).text,
               bench_cell(us, bench_median(us)).text, seconds.text, us->runs, speedup, must.text,
               speedup / threads[i], (unsigned long)ours->counters[4], (double)ours->counters[5] / thousand,
               (double)ours->counters[6] / thousand,
               ours->failure[0] != 0 ? ours->failure : ours->checked ? "checked" : "same");
        if (settings->phases) {
            bench_phases(us);
        }
        printf("\n");
    }
    fflush(stdout);
}

/* --------------------------------------------------------------------------------------------- plans --- */

/* A line means the product of its lists.  "all" threads: 1, 2, 4, ... and the number of cores; "most": the number of
   cores.  A rival makes a row only where it fits: TetGen in 3D, CGAL-TBB in 3D on several threads, and so on.
   rivals NULL: a sweep of the threads, the first of which is 1. */
typedef struct bench_plan {
    const char *mode, *dims, *kinds, *sizes, *threads, *rivals;
} bench_plan;

static const bench_plan bench_plans[] = {
    { "quick", "3,2", "uniform", "100,1000,1e4", "1", "all" },
    { "quick", "3,2", "all", "1e5", "1", "CGAL" },
    { "quick", "3,2", "uniform", "1e5", "all", NULL },
    { "default", "3,2", "uniform", "100,1000,1e4,1e5", "1", "all" },
    { "default", "3,2", "all", "1e6", "1", "CGAL" },
    { "default", "3", "uniform", "1e6", "most", "CGAL-TBB" },
    { "default", "3,2", "uniform", "1e6", "all", NULL },
    { "sweep", "3,2", "all", "1e6", "all", NULL },
    { "sweep", "3,2", "uniform", "1e7", "all", NULL },
    { "sweep", "3", "sphere", "2e5", "all", NULL },
    { "full", "3,2", "all", "100,1000,1e4,1e5", "1", "all" },
    { "full", "3,2", "all", "1e6,1e7", "1,most", "CGAL,CGAL-TBB,TetGen" },
    { "full", "3,2", "all", "1e6,1e7", "all", NULL },
    { "full", "3", "sphere", "2e5", "all", NULL }
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

/* The numbers of threads of a list, without repeats one after the other; returns how many. */
static int bench_threads(const char *list, int threads[BENCH_SIDES])
{
    int cores = bench_cores(), count = 0, most;
    char item[32];
    while (bench_next(&list, item)) {
        int all = strcmp(item, "all") == 0;
        most = all || strcmp(item, "most") == 0 ? cores : (int)bench_number(item);
        for (int t = all ? 1 : most; count < BENCH_SIDES; t = 2 * t < most ? 2 * t : most) {
            if (count == 0 || threads[count - 1] != t) {
                threads[count++] = t;
            }
            if (t == most) {
                break;
            }
        }
    }
    return count;
}

/* Makes the points and their rows. */
static void bench_points(bench_settings *settings, const struct bench_kind *kind, size_t dim, size_t count,
                         const bench_plan *plan)
{
    const size_t sets = count <= 1000 ? (size_t)settings->sets : 1;
    double *points = (double *)bench_map(sets * count * dim * sizeof(double), MAP_PRIVATE);
    double *weights = (double *)bench_map(sets * count * sizeof(double), MAP_PRIVATE);
    const char *name = kind->names[dim - 2];
    int threads[BENCH_SIDES], sides = bench_threads(plan->threads, threads), i;
    size_t set;
    bench_input input;
    memset(&input, 0, sizeof input);
    input.dim = (int)dim;
    input.count = count;
    input.sets = sets;
    input.points = points;
    input.weights = kind->weights >= 0 ? weights : NULL;
    for (set = 0; set < sets; set++) {
        double *here = points + set * count * dim;
        input_fill(kind->points, (int)dim, count, 1 + set, here);
        if (kind->weights >= 0) {
            input_fill_weights(kind->weights, (int)dim, count, 1 + set, here, weights + set * count);
        }
    }
    if (plan->rivals == NULL) {
        bench_sweep(settings, name, &input, threads, sides);
    }
    for (i = 0; i < sides && plan->rivals != NULL; i++) {
        input.threads = threads[i];
        bench_rows(settings, name, &input, plan->rivals);
    }
    munmap(points, sets * count * dim * sizeof(double));
    munmap(weights, sets * count * sizeof(double));
}

static void bench_follow(bench_settings *settings, const bench_plan *plan)
{
    const size_t kinds = sizeof bench_kinds / sizeof *bench_kinds;
    const char *dims = plan->dims, *sizes;
    char dim[32], size[32];
    size_t i;
    while (bench_next(&dims, dim)) {
        for (i = 0; i < kinds; i++) {
            if (!bench_listed(plan->kinds, bench_kinds[i].names[0])
                && !bench_listed(plan->kinds, bench_kinds[i].names[1])) {
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
    int threads[BENCH_SIDES], sides;
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
    sides = bench_threads(plan->threads, threads);
    for (i = 0; i < (size_t)sides; i++) {
        if (threads[i] < 1 || threads[i] > BENCH_THREADS) {
            return "threads must be numbers from 1 to 256, all or most";
        }
    }
    if (sides == 0 || (plan->rivals == NULL && threads[0] != 1)) {
        return "the threads of a sweep must begin with 1";
    }
    for (rest = plan->kinds; bench_next(&rest, item);) {
        for (i = 0; i < 2 * kinds && strcmp(item, bench_kinds[i / 2].names[i % 2]) != 0; i++) {
        }
        if (i == 2 * kinds && strcmp(item, "all") != 0) {
            return "a kind of points is unknown";
        }
    }
    for (rest = plan->rivals; rest != NULL && bench_next(&rest, item);) {
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
    "usage: bench [--quick | --sweep | --full] [options]\n"
    "  --quick             a minute, up to 1e5 points;  --full: hours, up to 1e7;  else a few minutes, up to 1e6\n"
    "  --sweep             1, 2, 4, ... threads instead of rivals\n"
    "  --dim 3,2           any of these five replaces the plan by the product of the five\n"
    "  --kinds LIST        uniform, gauss, ball, sphere (circle), clusters, lattice, lines, spiral,\n"
    "                      near-planar (near-collinear), anisotropic, terrain, weighted; all\n"
    "  --sizes LIST        such as 1000,1e6\n"
    "  --threads LIST      such as 1,4; all: 1, 2, 4, ... and the number of cores; most: only that\n"
    "  --rivals LIST       CGAL, CGAL-TBB, TetGen, Qhull; all; none\n"
    "  --phases            adds our phases and counters\n"
    "  --csv FILE          also writes a line for each side there, in seconds and bytes\n"
    "  --repeats N         most samples of a side (7)\n"
    "  --budget SECONDS    of a side, after which it takes no further sample (1 quick, 3, 20 full)\n"
    "  --limit SECONDS     ends a single sample (300)\n"
    "  --sets N            of at most 1000 points, that take turns (64); 1: the same points over and over\n";

/* What may explain the numbers: the machine, its load, the compiler. */
static void bench_machine(void)
{
    char line[256], model[200] = "unknown processor";
    double load = -1;
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
    printf("pbw %d.%d.%d, %s, %d cores", PBW_VERSION_MAJOR, PBW_VERSION_MINOR, PBW_VERSION_PATCH, model,
           bench_cores());
    if (getloadavg(&load, 1) == 1) {
        printf(", load %.2f before the start", load);
        if (load > 0.25 * bench_cores()) {
            printf("\nBUSY: other work is running here; times are too long, those on several threads most of all");
        }
    }
#ifdef __clang__
    printf("\ncompiler %s, %s", __VERSION__, BENCH_FLAGS);
#elif defined(__VERSION__)
    printf("\ncompiler gcc %s, %s", __VERSION__, BENCH_FLAGS);
#endif
    printf("\nrivals:");
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
    bench_settings settings;
    bench_plan own = { NULL, NULL, NULL, NULL, NULL, NULL };
    const char *mode = "default";
    int sweep = 0, last = -1, i;
    size_t p;

    memset(&settings, 0, sizeof settings);
    settings.repeats = 7;
    settings.limit = 300;
    settings.sets = BENCH_SETS;
    for (i = 1; i < argc; i++) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (strcmp(name, "--quick") == 0 || strcmp(name, "--full") == 0) {
            mode = name + 2;
            continue;
        }
        if (strcmp(name, "--sweep") == 0) {
            sweep = 1;
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
        } else if (strcmp(name, "--sets") == 0) {
            settings.sets = atoi(value);
        } else {
            return bench_fail("unknown option");
        }
    }
    if (settings.repeats < 1 || settings.repeats > BENCH_REPEATS) {
        return bench_fail("repeats must be 1 to 99");
    }
    if (settings.sets < 1 || settings.sets > BENCH_SETS) {
        return bench_fail("sets must be 1 to 64");
    }
    if (settings.budget <= 0) {
        settings.budget = strcmp(mode, "quick") == 0 ? 1 : strcmp(mode, "full") == 0 ? 20 : 3;
    }
    if (own.dims != NULL || own.kinds != NULL || own.sizes != NULL || own.threads != NULL || own.rivals != NULL) {
        own.mode = "own";
        own.dims = own.dims != NULL ? own.dims : "3,2";
        own.kinds = own.kinds != NULL ? own.kinds : "all";
        own.threads = own.threads != NULL ? own.threads : sweep ? "all" : "1";
        own.rivals = sweep ? NULL : own.rivals != NULL ? own.rivals : "all";
        if (own.sizes == NULL) {
            own.sizes = strcmp(mode, "quick") == 0 ? "1e5" : strcmp(mode, "full") == 0 ? "1e7" : "1e6";
        }
        if (bench_fault(&own) != NULL) {
            return bench_fail(bench_fault(&own));
        }
    } else if (sweep && strcmp(mode, "default") == 0) {
        mode = "sweep";
    }
    if (settings.csv != NULL) {
        fprintf(settings.csv, "points,dim,n,threads,side,best,median,runs,held,resident,simplices,checked,hash,"
                              "failure,order,build,output,walk,cavity,star,exact,walk_steps,conflict_tests,exact_tests,created,rounds,"
                              "postponed,serial\n");
    }
    bench_machine();
    for (p = 0; p < sizeof bench_plans / sizeof *bench_plans; p++) {
        const bench_plan *plan = own.mode != NULL ? &own : &bench_plans[p];
        if (own.mode == NULL && (strcmp(plan->mode, mode) != 0 || (sweep && plan->rivals != NULL))) {
            continue;
        }
        if (last != (plan->rivals == NULL)) {
            last = plan->rivals == NULL;
            bench_head(&settings, last);
        }
        bench_follow(&settings, plan);
        if (own.mode != NULL) {
            break;
        }
    }
    if (settings.csv != NULL) {
        fclose(settings.csv);
    }
    printf("\n%d of %d musts met\n", settings.met, settings.met + settings.missed);
    if (settings.faults != 0) {
        printf("%d FAULTS: results of ours that failed or differ, or counts that an exact rival contradicts\n",
               settings.faults);
    }
    return settings.faults != 0;
}
