/* gate_side.c: one sample of one header, for gate.py: gate_side DIM KIND COUNT THREADS [FLAGS]
   Prints the mean seconds of 1 + 100,000 / COUNT builds, at most 1,000, the peak of the library's memory in bytes a
   point, and a hash of all bytes of the result.  Of less than 100,000 points one build before is not counted.  How
   many there are does not depend on time, as the first build of a process is slower: its memory is new. */
#define _DEFAULT_SOURCE
#define PBW_IMPLEMENTATION
#include PBW_HEADER
#include "../tests/inputs.h"

#include <stdio.h>
#include <time.h>

static double gate_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static uint64_t gate_hash(uint64_t hash, const void *bytes, size_t size)       /* FNV-1a over words, then bytes */
{
    const unsigned char *byte = (const unsigned char *)bytes;
    uint64_t word;
    for (; size >= sizeof word; byte += sizeof word, size -= sizeof word) {
        memcpy(&word, byte, sizeof word);
        hash = (hash ^ word) * 0x100000001b3u;
        hash ^= hash >> 29;
    }
    for (; size > 0; byte++, size--) {
        hash = (hash ^ *byte) * 0x100000001b3u;
    }
    return hash;
}

static uint64_t gate_mesh_hash(const pbw_mesh *mesh)
{
    size_t corners = (size_t)mesh->dim + 1, ids = mesh->simplex_count * corners * sizeof(pbw_index);
    uint64_t hash = 0xcbf29ce484222325u;
    hash = gate_hash(hash, mesh->simplices, ids);
    hash = gate_hash(hash, mesh->neighbors, ids);
    hash = gate_hash(hash, mesh->incident, mesh->point_count * sizeof(pbw_index));
    hash = gate_hash(hash, mesh->canonical, mesh->point_count * sizeof(pbw_index));
    return gate_hash(hash, mesh->points, mesh->point_count * (size_t)mesh->dim * sizeof(double));
}

int main(int argc, char **argv)
{
    const int dim = argc > 4 ? atoi(argv[1]) : 0, weighted = argc > 4 && strcmp(argv[2], "weighted") == 0;
    const size_t count = argc > 4 ? (size_t)strtoull(argv[3], NULL, 10) : 0;
    const int builds = count < 101 ? 1000 : 1 + (int)(100000 / count);
    int kind = 0, build;
    double *points, *weights = NULL, seconds = 0, start;
    pbw_options options;
    pbw_mesh mesh;
    while (argc > 4 && !weighted && kind < INPUT_KINDS && strcmp(input_name(kind), argv[2]) != 0) {
        kind++;
    }
    if ((dim != 2 && dim != 3) || count == 0 || kind == INPUT_KINDS) {
        fprintf(stderr, "gate_side DIM KIND COUNT THREADS [FLAGS]\n");
        return 2;
    }
    points = (double *)malloc(count * (size_t)dim * sizeof(double));
    if (weighted) {
        weights = (double *)malloc(count * sizeof(double));
    }
    if (points == NULL || (weighted && weights == NULL)) {
        return 1;
    }
    input_fill(kind, dim, count, 1, points);
    if (weighted) {
        input_fill_weights(INPUT_WEIGHTS_HIDING, dim, count, 1, points, weights);
    }
    memset(&options, 0, sizeof options);
    memset(&mesh, 0, sizeof mesh);
    options.threads = atoi(argv[4]);
    options.flags = argc > 5 ? (unsigned)atoi(argv[5]) : 0;
    for (build = count < 100000 ? -1 : 0; build < builds; build++) {
        pbw_free(&mesh);
        start = gate_seconds();
        if (pbw_triangulate(dim, points, weights, count, &options, &mesh) != PBW_OK) {
            return 1;
        }
        seconds += build >= 0 ? gate_seconds() - start : 0;
    }
    printf("%.9f %.2f %016llx\n", seconds / builds, (double)mesh.statistics.peak_bytes / (double)count,
           (unsigned long long)gate_mesh_hash(&mesh));
    pbw_free(&mesh);
    free(points);
    free(weights);
    return 0;
}
