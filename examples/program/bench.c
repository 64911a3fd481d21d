/* bench.c: pbw bench. */
#include "program.h"
#ifndef _WIN32
#include <unistd.h>
#endif

static int cores(void)
{
    int count = 1;
#ifdef _SC_NPROCESSORS_ONLN
    count = (int)sysconf(_SC_NPROCESSORS_ONLN);
#endif
    return count < 1 ? 1 : count > 256 ? 256 : count;
}

/* The best time of three builds; negative after a failure. */
static double best_of_three(job *j, int threads)
{
    double best = DBL_MAX, start;
    pbw_status built;
    int run;
    for (run = 0; run < 3; run++) {
        start = now();
        pbw_free(&j->mesh);
        j->build.threads = threads;
        built = pbw_triangulate(j->cloud.dim, j->cloud.points, j->cloud.weights, j->cloud.count, &j->build, &j->mesh);
        best = now() - start < best ? now() - start : best;
        if (built != PBW_OK) {
            (void)explain(j, built);
            return -1;
        }
    }
    return best;
}

static int run(job *j)
{
    int status, threads, most = j->build.threads == 0 ? cores() : j->build.threads;
    uint64_t hash = 0, found;
    double best;
    if (j->input == NULL && j->generate == NULL) {
        j->generate = "uniform";
        j->count = 1000000;
    }
    status = load(j, 1);
    if (status != 0) {
        return status;
    }
    printf("threads   seconds   M points/s   bytes/point   simplices   hash\n");
    for (threads = 1;; threads = 2 * threads < most ? 2 * threads : most) {
        best = best_of_three(j, threads);
        if (best < 0) {
            return FAILURE;
        }
        found = pbw_hash(&j->mesh, NULL);
        fputs(j->terminal ? "\r\033[K" : "", stderr);
        printf("%7d %9.3f %12.3f %13.0f %11zu   %016llx\n", threads, best, (double)j->cloud.count / best * 1e-6,
               (double)j->mesh.statistics.peak_bytes / (double)j->cloud.count, j->mesh.simplex_count,
               (unsigned long long)found);
        fflush(stdout);
        if (threads > 1 && found != hash) {
            return fail(j, "the result is wrong: please report this");
        }
        hash = found;
        if (threads == most) {
            return check(j);
        }
    }
}

const command command_bench = {
    .name = "bench",
    .summary = "measure",
    .usage =
    "usage: pbw bench [options] [input]\n"
    "\n"
    "Times of the triangulation by number of threads, best of three; default: --generate uniform 1000000.\n"
    "\n",
    .options = { input_options, weight_options, build_options, common_options, NULL },
    .run = run,
    .may_lack_input = 1,
};
