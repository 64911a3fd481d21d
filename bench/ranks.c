/* ranks.c: what bench/ranks.sh sets beside ranks: threads of one process on the same points.
   ./bench_ranks points.bin THREADS [REPEAT]        best time of pbw_triangulate, and the hash, for a file of x y z
   ./bench_ranks --write points.bin COUNT           uniform points, whatever their number: memory does not limit it */
#define _POSIX_C_SOURCE 199309L                      /* clock_gettime beside strict C99 */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int fail(const char *path, const char *what)
{
    fprintf(stderr, "%s: %s\n", path, what);
    return 1;
}

static double random_of(uint64_t i)                  /* splitmix64 (Steele, Lea and Flood 2014), from 0 to 1 */
{
    i = (i + 1) * 0x9e3779b97f4a7c15u;
    i = (i ^ i >> 30) * 0xbf58476d1ce4e5b9u;
    i = (i ^ i >> 27) * 0x94d049bb133111ebu;
    return (double)((i ^ i >> 31) >> 11) / 9007199254740992.0;
}

static int write_points(const char *path, uint64_t count)
{
    static double block[3 * 4096];
    FILE *file = fopen(path, "wb");
    uint64_t i, n = 0;
    int good = file != NULL;
    for (i = 0; i < 3 * count && good; i++) {
        block[n++] = random_of(i);
        if (n == 3 * 4096 || i + 1 == 3 * count) {
            good = fwrite(block, sizeof *block, (size_t)n, file) == n;
            n = 0;
        }
    }
    return (file == NULL || fclose(file) == 0) && good ? 0 : fail(path, "cannot write");
}

/* The points of a file; NULL if it cannot be read. */
static double *read_points(const char *path, size_t *count)
{
    FILE *file = fopen(path, "rb");
    const long size = file != NULL && fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    double *x = NULL;
    *count = size > 0 ? (size_t)size / 24 : 0;
    if (size >= 0) {
        rewind(file);
        x = (double *)malloc(*count * 24 + 1);
    }
    if (x != NULL && fread(x, 24, *count, file) != *count) {
        free(x);
        x = NULL;
    }
    if (file != NULL) {
        fclose(file);
    }
    return x;
}

static int triangulate(const char *path, int threads, int repeat)
{
    size_t count;
    double *x = read_points(path, &count), best = 1e300, hashing = 0;
    pbw_options options;
    pbw_status status = PBW_OK;
    uint64_t hash = 0;
    size_t simplices = 0, bytes = 0;
    memset(&options, 0, sizeof options);
    options.threads = threads;
    for (; repeat > 0 && x != NULL && status == PBW_OK; repeat--) {
        double start = now();
        pbw_mesh mesh;
        status = pbw_triangulate(3, x, NULL, count, &options, &mesh);
        best = now() - start < best ? now() - start : best;
        if (status == PBW_OK && repeat == 1) {
            start = now();
            hash = pbw_hash(&mesh, &options);
            hashing = now() - start;
            simplices = mesh.simplex_count;
            bytes = mesh.statistics.peak_bytes;
        }
        pbw_free(&mesh);
    }
    free(x);
    if (x == NULL || status != PBW_OK) {
        return fail(path, x == NULL ? "cannot read" : pbw_status_string(status));
    }
    printf("%d threads: %.0f points, %.0f simplices, hash %016llx, memory %.0f bytes a point; seconds: "
           "triangulation %.2f, hash %.2f\n", threads, (double)count, (double)simplices, (unsigned long long)hash,
           (double)bytes / (double)count, best, hashing);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], "--write") == 0) {
        return write_points(argv[2], strtoull(argv[3], NULL, 10));
    }
    if (argc < 3 || argc > 4 || atoi(argv[2]) < 1) {
        fprintf(stderr, "usage: bench_ranks points.bin THREADS [REPEAT], or --write points.bin COUNT\n");
        return 2;
    }
    return triangulate(argv[1], atoi(argv[2]), argc > 3 ? atoi(argv[3]) : 1);
}
