/* hashes.c: prints, for each of many inputs, a hash of all arrays that pbw made, byte by byte, and pbw_hash; then
   those of a few others for which they are not what is stored here.  hashes N prints every N-th line, from the first.
   tests/hashes.sh and arm.sh compare what differently compiled programs print. */
#ifndef PBW__IMPLEMENTED
#define PBW_STATIC                                   /* what is not called here is not compiled */
#endif
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

/* All arrays, byte for byte. */
static uint64_t hash_mesh(const pbw_mesh *mesh)
{
    size_t links = mesh->simplex_count * (size_t)(mesh->dim + 1) * sizeof(pbw_index);
    uint64_t hash = 0xcbf29ce484222325u;
    hash = hash_bytes(hash, mesh->simplices, links);
    hash = hash_bytes(hash, mesh->neighbors, links);
    hash = hash_bytes(hash, mesh->incident, mesh->point_count * sizeof(pbw_index));
    hash = hash_bytes(hash, mesh->canonical, mesh->point_count * sizeof(pbw_index));
    hash = hash_bytes(hash, mesh->points, mesh->point_count * (size_t)mesh->dim * sizeof(double));
    return hash_bytes(hash, mesh->weights, mesh->point_count * sizeof(double));
}

static void print_hashes(const zoo_input *in, pbw_status status, const pbw_mesh *mesh)
{
    printf("%s: %d %lu %lu %lu %016llx %016llx\n", in->name, (int)status, (unsigned long)mesh->simplex_count,
           (unsigned long)mesh->duplicate_count, (unsigned long)mesh->hidden_count,
           (unsigned long long)hash_mesh(mesh), (unsigned long long)pbw_hash(mesh, NULL));
}

/* What these inputs gave when this was written, in the plane and in space: every version, compiler and processor is to
   give the same.  The first hash tells the order of the arrays too, the second one, pbw_hash, the triangulation alone. */
static const struct stored {
    int kind, weights, times;                                 /* weights -1: none; times: copies of each point */
    size_t count;
    uint64_t hash[2][2];
} stored[] = {
    { INPUT_UNIFORM, -1, 1, 12001,
      { { 0xaa0087642d32a617u, 0x0fd50e1bb544bddcu }, { 0x4b601d02618dfd0du, 0x1415d77e4262e327u } } },
    { INPUT_UNIFORM, INPUT_WEIGHTS_HALF, 1, 3001,
      { { 0x26650756506a97a4u, 0x98608898eea7ba2bu }, { 0x03a7c69945c4367au, 0x44768cd95d7e1120u } } },
    { INPUT_UNIFORM, INPUT_WEIGHTS_HIDING, 3, 1001,
      { { 0xd8c990c167a48205u, 0x293dafb68a25e886u }, { 0x631c6aedbcc49768u, 0xad01b4a5d4be0179u } } },
    { INPUT_SPHERE, -1, 1, 2001,
      { { 0x8f570e9b3c894828u, 0xb6b7b8a931ff76f9u }, { 0x8a76908ed34c1c08u, 0x10ae54b79d1df2b6u } } },
    { INPUT_CLUSTERS, -1, 1, 3001,
      { { 0x745f775448619634u, 0xad565d0932ad4b06u }, { 0x599903580bf6f212u, 0x356fa5a9b03eb10fu } } },
    { INPUT_LATTICE, -1, 1, 2001,
      { { 0xbc3bafe88c27f34bu, 0x79582b7ef994f18du }, { 0xf0a5118c6d1e6415u, 0x71fa4b1dc114ae54u } } },
    { INPUT_LATTICE, -1, 4, 501,
      { { 0x4445c6d7a6101465u, 0x1106f0e3b052b9acu }, { 0xe5f06a7850d793feu, 0x949128cc651951b7u } } },
    { INPUT_LATTICE, INPUT_WEIGHTS_LEVELS, 1, 2001,
      { { 0xab179df558fa770fu, 0x51e204fd48cfa946u }, { 0xe89bc6729a74e759u, 0xd2daf68613dc636bu } } },
    { INPUT_TERRAIN, -1, 1, 3001,
      { { 0x580cf032956c87c2u, 0xbf7ac65050101c98u }, { 0x8fcd628bcb9c769fu, 0x1faed34068d1e2cau } } },
    { INPUT_PLANE, -1, 1, 2001,
      { { 0x6990d5283413ec2du, 0xda951b0f50000056u }, { 0xcc28e708319faa82u, 0x94cfaef32f0a7045u } } },
    { INPUT_MOMENT, -1, 1, 201,
      { { 0x3bfaf2db4edf1285u, 0x503290d434e4f51fu }, { 0x19128df576ff5808u, 0x8fb3dd013f21292au } } }
};

/* Prints those that give something else now. */
static void print_changed(void)
{
    size_t i;
    for (i = 0; i < 2 * sizeof stored / sizeof stored[0]; i++) {
        const struct stored *was = stored + i / 2;
        const int dim = 2 + (int)(i % 2);
        zoo_input *in;
        pbw_mesh mesh;
        pbw_status status;
        zoo z;
        memset(&z, 0, sizeof z);
        zoo_kind(&z, dim, was->kind, was->count);
        zoo_repeat(&z, was->times);
        if (was->weights >= 0) {
            zoo_weigh(&z, was->weights);
        }
        in = zoo_last(&z);
        status = pbw_triangulate(dim, in->points, in->weights, in->count, NULL, &mesh);
        if (hash_mesh(&mesh) != was->hash[dim - 2][0] || pbw_hash(&mesh, NULL) != was->hash[dim - 2][1]) {
            printf("CHANGED, entry %d of the table: ", (int)(i / 2));
            print_hashes(in, status, &mesh);
        }
        pbw_free(&mesh);
        zoo_free(&z);
    }
}

int main(int argc, char **argv)
{
    const size_t step = argc > 1 ? strtoul(argv[1], NULL, 10) : 1;
    zoo animals;
    size_t i;
    int kind, power;
    zoo_fill(&animals);
    for (kind = 0; kind < INPUT_KINDS; kind++) {
        zoo_kind(&animals, 2, kind, 2001);
        zoo_kind(&animals, 3, kind, kind == INPUT_MOMENT ? 201 : 2001);
        if (kind != INPUT_MOMENT) {
            zoo_weigh(&animals, INPUT_WEIGHTS_HALF);
        }
    }
    for (power = -540; power <= 540; power += 20) {           /* on a circle and on a line, rounded */
        zoo_new(&animals, 2, "ring, times 2^%d", power), zoo_ring(&animals, 50, 0.7, 0);
        zoo_scale(&animals, ldexp(1, power), 0);
        zoo_new(&animals, 2, "line, times 2^%d", power);
        for (kind = 1; kind < 50; kind++) {
            zoo_add(&animals, kind / 50.0, kind / 50.0 * 0.77, 0);
        }
        zoo_scale(&animals, ldexp(1, power), 0);
    }
    for (i = 0; i < animals.count && step > 0; i += step) {
        const zoo_input *in = animals.items + i;
        pbw_mesh mesh;
        pbw_status status = pbw_triangulate(in->dim, in->points, in->weights, in->count, NULL, &mesh);
        print_hashes(in, status, &mesh);
        pbw_free(&mesh);
    }
    zoo_free(&animals);
    print_changed();
    return 0;
}
