/* hashes.c: prints, for each of many inputs, a hash of all arrays that pbw made, byte by byte, and pbw_hash.
   tests/hashes.sh compares what differently compiled programs print. */
#define PBW_IMPLEMENTATION
#include "../pbw.h"
#include "zoo.h"

static uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t count)   /* FNV-1a */
{
    const unsigned char *at = (const unsigned char *)bytes;
    size_t i;
    for (i = 0; i < count && at != NULL; i++) {
        hash = (hash ^ at[i]) * 0x100000001b3u;
    }
    return hash;
}

int main(void)
{
    zoo animals;
    size_t i;
    int kind;
    zoo_fill(&animals);
    for (kind = 0; kind < INPUT_KINDS; kind++) {
        zoo_kind(&animals, 2, kind, 2001);
        zoo_kind(&animals, 3, kind, kind == INPUT_MOMENT ? 201 : 2001);
        if (kind != INPUT_MOMENT) {
            zoo_weigh(&animals, INPUT_WEIGHTS_HALF);
        }
    }
    for (i = 0; i < animals.count; i++) {
        const zoo_input *in = animals.items + i;
        pbw_mesh mesh;
        pbw_status status = pbw_triangulate(in->dim, in->points, in->weights, in->count, NULL, &mesh);
        size_t links = mesh.simplex_count * (size_t)(mesh.dim + 1) * sizeof(pbw_index);
        uint64_t hash = 0xcbf29ce484222325u;
        hash = hash_bytes(hash, mesh.simplices, links);
        hash = hash_bytes(hash, mesh.neighbors, links);
        hash = hash_bytes(hash, mesh.incident, mesh.point_count * sizeof(pbw_index));
        hash = hash_bytes(hash, mesh.canonical, mesh.point_count * sizeof(pbw_index));
        hash = hash_bytes(hash, mesh.points, mesh.point_count * (size_t)mesh.dim * sizeof(double));
        hash = hash_bytes(hash, mesh.weights, mesh.point_count * sizeof(double));
        printf("%s: %d %lu %lu %lu %016llx %016llx\n", in->name, (int)status, (unsigned long)mesh.simplex_count,
               (unsigned long)mesh.duplicate_count, (unsigned long)mesh.hidden_count, (unsigned long long)hash,
               (unsigned long long)pbw_hash(&mesh));
        pbw_free(&mesh);
    }
    zoo_free(&animals);
    return 0;
}
