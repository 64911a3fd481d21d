/* pbwt.c: what commands do with .pbwt files: pbw hash, pbw check and pbw convert of them.

   The proof: every simplex is positive; links lead back, across tiles too, to simplices that share the facet, on its
   other side, and whose other corner is not in conflict; facets without a link are those of the hull of their own
   vertices.  So the simplices cover the hull once, and are regular everywhere.  Each point is a corner (with weights:
   or hidden, which is not proved), points in several tiles are equal, ids are different; each simplex is in the tile
   it belongs to; checksums, counts and hashes, of each tile and of all, are right. */
#include "program.h"
#include "pbw_tilefile.h"

typedef struct hull_facet { uint64_t key[3]; } hull_facet;           /* ascending; 2D: the last is 0 */

enum { CORNER = 1, ON_HULL = 2, GIVEN = 4 };         /* marks of points: given up to the leftovers */

typedef struct proof {
    job *j;
    pbwtf_file file;
    pbwtf_chunk *head;                               /* of each chunk, where its view has it */
    pbwtf_view *view;
    size_t dim, corners, chunk;                      /* chunk: under test */
    unsigned char **seen;                            /* per chunk, a byte a point: marks */
    hull_facet *facets;
    size_t facet_count;
    /* Each id takes a bit by its last digits.  Those that share one, none of numbers of the input, are compared. */
    unsigned char *once, *twice;                     /* bits that were taken; more than once */
    size_t bits, sharing, id_count;
    uint64_t *ids;
    pbw_hash_sums sums;
} proof;

int is_pbwt(const job *j)
{
    const char *dot = j->input != NULL ? strrchr(j->input, '.') : NULL;
    return dot != NULL && strcmp(dot, ".pbwt") == 0;
}

/* ---- access ---- */

/* Bytes of a chunk; those of the one under test have been fetched. */
static const void *bytes_of(const proof *p, size_t chunk, const void *from, size_t size)
{
    return chunk == p->chunk ? from : pbwtf_fetch(&p->file.map, from, size);
}

static const uint32_t *record_of(const proof *p, size_t chunk, size_t simplex)
{
    const pbwtf_view *v = p->view + chunk;
    return (const uint32_t *)bytes_of(p, chunk, v->simplices + simplex * v->simplex_size, v->simplex_size * 4);
}

static const double *point_of(const proof *p, size_t chunk, uint32_t corner)
{
    const pbwtf_view *v = p->view + chunk;
    return (const double *)(corner < v->chunk->own
         ? bytes_of(p, chunk, v->own + corner * v->own_size, v->own_size * 8)
         : bytes_of(p, chunk, v->foreign + (corner - v->chunk->own) * v->foreign_size, v->foreign_size * 8));
}

static uint64_t key_of(const proof *p, size_t chunk, uint32_t corner)            /* tile << 32 | number there */
{
    const pbwtf_view *v = p->view + chunk;
    uint64_t key = (uint64_t)chunk << 32 | corner;
    if (corner >= v->chunk->own) {
        memcpy(&key, point_of(p, chunk, corner) + v->own_size, sizeof key);
    }
    return key;
}

static uint64_t id_of(const proof *p, size_t chunk, uint32_t corner)
{
    uint64_t id;
    memcpy(&id, point_of(p, chunk, corner) + p->view[chunk].own_size - 1, sizeof id);
    return id;
}

static int compare_keys(const void *a, const void *b)
{
    uint64_t x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return x < y ? -1 : x > y;
}

static void facet_of(const proof *p, size_t chunk, size_t simplex, size_t corner, uint64_t *key)
{
    size_t k, n = 0;
    key[2] = 0;
    for (k = 0; k < p->corners; k++) {
        if (k != corner) {
            key[n++] = key_of(p, chunk, record_of(p, chunk, simplex)[k]);
        }
    }
    qsort(key, n, sizeof *key, compare_keys);
}

/* ---- simplices ---- */

static int is_on_hull(const pbwtf_view *v, uint32_t link)
{
    return link == PBWT_HULL || (link >= 0x80000000u && link - 0x80000000u < v->chunk->across
                                 && v->across[link - 0x80000000u] == PBWT_NOTHING);
}

static int orientation(const proof *p, const double *const *x)
{
    return p->dim == 2 ? pbw_orient2(x[0], x[1], x[2]) : pbw_orient3(x[0], x[1], x[2], x[3]);
}

static const char *check_pair(const proof *p, size_t simplex, size_t k, size_t other_chunk, size_t other, size_t apex)
{
    const uint32_t *record = record_of(p, p->chunk, simplex);
    const double *x[4], *q = point_of(p, other_chunk, record_of(p, other_chunk, other)[apex]), *w = NULL, *old;
    double weights[5];
    uint64_t mine[3], theirs[3];
    size_t i;
    int conflict;
    facet_of(p, p->chunk, simplex, k, mine);
    facet_of(p, other_chunk, other, apex, theirs);
    if (memcmp(mine, theirs, sizeof mine) != 0) {
        return "a link leads to a simplex without that facet";
    }
    for (i = 0; i < p->corners; i++) {
        x[i] = point_of(p, p->chunk, record[i]);
        weights[i] = x[i][p->dim];
    }
    weights[p->corners] = q[p->dim];
    w = p->file.header->flags & PBWTF_WEIGHTS ? weights : NULL;
    old = x[k];
    x[k] = q;
    if (orientation(p, x) >= 0) {
        return "two simplices lie on one side of their facet";
    }
    x[k] = old;
    conflict = p->dim == 2 ? pbw_conflict2(x[0], x[1], x[2], q, w) : pbw_conflict3(x[0], x[1], x[2], x[3], q, w);
    return conflict ? "a facet is not regular" : NULL;
}

/* The link of a simplex across corner k. */
static const char *check_link(const proof *p, size_t simplex, size_t k)
{
    const pbwtf_view *v = p->view + p->chunk;
    const uint32_t link = record_of(p, p->chunk, simplex)[p->corners + k];
    size_t other = link, other_chunk = p->chunk, apex;
    const uint32_t *back;
    if (is_on_hull(v, link)) {
        return NULL;
    }
    if (link >= 0x80000000u) {
        const uint64_t to = link - 0x80000000u < v->chunk->across ? v->across[link - 0x80000000u] : PBWT_NOTHING;
        other_chunk = (size_t)(to >> 40);
        other = (size_t)(to & 0xffffffffffu) >> 2;
        apex = (size_t)(to & 3);
        if (other_chunk >= p->file.header->chunks || other >= p->view[other_chunk].chunk->simplices
            || apex >= p->corners) {
            return "a link across tiles leads nowhere";
        }
        back = record_of(p, other_chunk, other) + p->corners + apex;
        if (*back < 0x80000000u || *back - 0x80000000u >= p->view[other_chunk].chunk->across
            || *(const uint64_t *)bytes_of(p, other_chunk, p->view[other_chunk].across + (*back - 0x80000000u), 8)
               != ((uint64_t)p->chunk << 40 | (uint64_t)simplex << 2 | k)) {
            return "a link across tiles does not lead back";
        }
        return other_chunk < p->chunk ? NULL : check_pair(p, simplex, k, other_chunk, other, apex);
    }
    if (other >= v->chunk->simplices) {
        return "a link leads nowhere";
    }
    back = record_of(p, p->chunk, other);
    for (apex = 0; apex < p->corners && back[p->corners + apex] != simplex; apex++) {
    }
    return apex == p->corners ? "a link does not lead back"
         : other < simplex ? NULL : check_pair(p, simplex, k, other_chunk, other, apex);
}

static const char *check_simplex(const proof *p, size_t simplex)
{
    const double *x[4];
    const char *fault = NULL;
    size_t k;
    for (k = 0; k < p->corners; k++) {
        x[k] = point_of(p, p->chunk, record_of(p, p->chunk, simplex)[k]);
    }
    if (orientation(p, x) <= 0) {
        return "a simplex is flat or turned";
    }
    for (k = 0; k < p->corners && fault == NULL; k++) {
        fault = check_link(p, simplex, k);
    }
    return fault;
}

static pbw_status check_range(void *arg, size_t from, size_t to)
{
    for (; from < to; from++) {
        if (check_simplex((const proof *)arg, from) != NULL) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    return PBW_OK;
}

/* ---- chunks ---- */

static int fault_in(const proof *p, const char *what)
{
    return pbwtf_fault(&p->file.map) != NULL ? fail(p->j, "%s: %s", p->j->input, pbwtf_fault(&p->file.map))
         : fail(p->j, "tile %lu: %s", (unsigned long)p->chunk, what);
}

static void fetch_chunk(const proof *p)
{
    const pbwtf_view *v = p->view + p->chunk;
    pbwtf_fetch(&p->file.map, v->own, v->size - sizeof *v->chunk);
}

enum { MOST_BYTES = 3 << 23 };                       /* of the file that stay in memory from tile to tile */

/* A step for each chunk, which is in memory meanwhile, so that a tile needs to fit and not the file. */
static int for_chunks(proof *p, int (*step)(proof *p))
{
    int failed = 0;
    for (p->chunk = 0; p->chunk < p->file.header->chunks && !failed; p->chunk++) {
        fetch_chunk(p);
        failed = step(p);
        failed = !failed && pbwtf_fault(&p->file.map) != NULL ? fault_in(p, "") : failed;
        if (pbwtf_fetched(&p->file.map) > MOST_BYTES) {
            pbwtf_forget(&p->file.map);
        }
    }
    return failed;
}

static int check_bytes(const proof *p)
{
    return pbwtf_is_intact(p->view + p->chunk, p->file.table + p->chunk) && pbwtf_fault(&p->file.map) == NULL ? 0
         : fault_in(p, "the checksum is wrong: the file is damaged");
}

/* Foreign points are points of other tiles, each once. */
static int check_foreign(const proof *p)
{
    const pbwtf_view *v = p->view + p->chunk;
    const size_t own = (size_t)v->chunk->own, count = (size_t)v->chunk->foreign;
    uint64_t *keys = (uint64_t *)malloc((count + 1) * sizeof *keys);
    const char *fault = NULL;
    size_t i;
    if (keys == NULL) {
        return fail(p->j, "out of memory");
    }
    for (i = 0; i < count && fault == NULL; i++) {
        const uint64_t key = keys[i] = key_of(p, p->chunk, (uint32_t)(own + i));
        fault = key >> 32 >= p->file.header->tiles || (key & 0xffffffffu) >= p->view[key >> 32].chunk->own
             || memcmp(point_of(p, p->chunk, (uint32_t)(own + i)), point_of(p, (size_t)(key >> 32), (uint32_t)key),
                       v->own_size * 8) != 0 ? "a point differs from that of its tile"
             : key >> 32 == p->chunk ? "a point of its own is among those of others" : NULL;
    }
    if (fault == NULL) {
        qsort(keys, count, sizeof *keys, compare_keys);
        for (i = 1; i < count && keys[i - 1] != keys[i]; i++) {
        }
        fault = i < count ? "a point of another tile is there twice" : NULL;
    }
    free(keys);
    return fault != NULL ? fault_in(p, fault) : 0;
}

/* Points given up ascend; marks them. */
static int check_given(proof *p)
{
    const pbwtf_view *v = p->view + p->chunk;
    size_t i;
    pbwtf_fetch(&p->file.map, v->given, (size_t)v->chunk->given * 4);
    for (i = 0; i < v->chunk->given; i++) {
        if (v->given[i] >= v->chunk->own || (i > 0 && v->given[i] <= v->given[i - 1])) {
            return fault_in(p, "the list of points given up is wrong");
        }
        p->seen[p->chunk][v->given[i]] |= GIVEN;
    }
    return p->file.header->chunks > p->file.header->tiles || v->chunk->given == 0 ? 0
         : fault_in(p, "it gave up points, and the file has no tile of leftovers");
}

static int add_hull_facet(proof *p, size_t simplex, size_t corner)
{
    hull_facet *facets = p->facets;
    size_t i;
    if ((p->facet_count & (p->facet_count - 1)) == 0) {              /* a power of two: full */
        facets = (hull_facet *)realloc(p->facets, (2 * p->facet_count + 2) * sizeof *facets);
        if (facets == NULL) {
            return fail(p->j, "out of memory: the hull");
        }
        p->facets = facets;
    }
    facets += p->facet_count++;
    memset(facets, 0, sizeof *facets);
    facet_of(p, p->chunk, simplex, corner, facets->key);
    for (i = 0; i < p->dim; i++) {
        p->seen[facets->key[i] >> 32][facets->key[i] & 0xffffffffu] |= ON_HULL;
    }
    return 0;
}

/* Whether a simplex is in the chunk it belongs to, by its corner with the smallest id. */
static int is_at_home(const proof *p, size_t simplex)
{
    const uint32_t *record = record_of(p, p->chunk, simplex);
    uint64_t least = id_of(p, p->chunk, record[0]), key = key_of(p, p->chunk, record[0]);
    size_t k, home;
    for (k = 1; k < p->corners; k++) {
        const uint64_t id = id_of(p, p->chunk, record[k]);
        if (id < least) {
            least = id;
            key = key_of(p, p->chunk, record[k]);
        }
    }
    home = p->seen[key >> 32][key & 0xffffffffu] & GIVEN ? p->file.header->tiles : (size_t)(key >> 32);
    return home == p->chunk;
}

/* Marks corners, collects facets of the hull, counts links. */
static int read_simplices(proof *p)
{
    const pbwtf_view *v = p->view + p->chunk;
    const uint64_t points = v->chunk->own + v->chunk->foreign;
    uint64_t hull = 0, across = 0;
    size_t s, k;
    for (s = 0; s < v->chunk->simplices; s++) {
        const uint32_t *record = record_of(p, p->chunk, s);
        for (k = 0; k < p->corners; k++) {
            if (record[k] >= points) {
                return fault_in(p, "a corner is no point");
            }
        }
        if (!is_at_home(p, s)) {
            return fault_in(p, "a simplex belongs to another tile");
        }
        for (k = 0; k < p->corners; k++) {
            const uint64_t key = key_of(p, p->chunk, record[k]);
            const uint32_t link = record[p->corners + k];
            p->seen[key >> 32][key & 0xffffffffu] |= CORNER;
            hull += link == PBWT_HULL;
            if (link != PBWT_HULL && link >= 0x80000000u && link - 0x80000000u != across++) {
                return fault_in(p, "links across tiles are not in their order");
            }
            if (is_on_hull(v, link) && add_hull_facet(p, s, k)) {
                return FAILURE;
            }
        }
    }
    return hull == v->chunk->hull && across == v->chunk->across ? 0
         : fault_in(p, "the numbers of links in its head are wrong");
}

static void take_bits(proof *p)
{
    uint64_t i;
    for (i = 0; i < p->view[p->chunk].chunk->own; i++) {
        const size_t bit = (size_t)(id_of(p, p->chunk, (uint32_t)i) % p->bits);
        const unsigned char mark = (unsigned char)(1u << bit % 8), again = p->once[bit / 8] & mark;
        p->sharing += again == 0 ? 0 : p->twice[bit / 8] & mark ? 1 : 2;
        p->twice[bit / 8] |= again;
        p->once[bit / 8] |= mark;
    }
}

static void collect_ids(proof *p)
{
    uint64_t i;
    for (i = 0; i < p->view[p->chunk].chunk->own && p->sharing > 0; i++) {
        const uint64_t id = id_of(p, p->chunk, (uint32_t)i);
        const size_t bit = (size_t)(id % p->bits);
        if (p->twice[bit / 8] >> bit % 8 & 1) {
            p->ids[p->id_count++] = id;
        }
    }
}

static int read_chunk(proof *p)
{
    int failed = check_bytes(p);
    failed = failed ? failed : check_foreign(p);
    take_bits(p);
    return failed ? failed : read_simplices(p);
}

/* All chunks for the first time: what later steps rely on. */
static int read_chunks(proof *p)
{
    uint64_t points = 0;
    size_t c;
    int failed = 0;
    for (c = 0; c < p->file.header->tiles; c++) {
        points += p->view[c].chunk->own;
    }
    for (p->bits = 8; p->bits < points; p->bits *= 2) {
    }
    p->once = (unsigned char *)calloc(p->bits / 8, 2);
    if (p->once == NULL) {
        return fail(p->j, "out of memory: ids");
    }
    p->twice = p->once + p->bits / 8;
    for (p->chunk = 0; p->chunk < p->file.header->chunks && !failed; p->chunk++) {
        failed = check_given(p);                     /* of all tiles first: each simplex needs some of them */
    }
    failed = failed ? failed : for_chunks(p, read_chunk);
    p->ids = (uint64_t *)malloc((p->sharing + 1) * sizeof *p->ids);
    return !failed && p->ids == NULL ? fail(p->j, "out of memory: ids") : failed;
}

/* ---- the hash ---- */

static int add_hash(proof *p)
{
    const pbwtf_view *v = p->view + p->chunk;
    pbw_hash_sums own;
    pbw_mesh mesh;
    pbw_status status = PBW_ERROR_MEMORY;
    unsigned char *chosen = (unsigned char *)calloc((size_t)(v->chunk->own + v->chunk->foreign) + 1, 1);
    if (chosen != NULL && pbwtf_mesh(v, NULL, &mesh) == PBW_OK) {
        memset(chosen, 1, (size_t)v->chunk->own);
        status = pbw_hash_parts(&mesh, chosen, NULL, &p->j->build, &own);
        p->sums.points += own.points;
        p->sums.simplices += own.simplices;
        pbwtf_mesh_free(&mesh);
        if (status == PBW_OK && memcmp(&own, &v->chunk->hash, sizeof own) != 0) {
            free(chosen);
            return fault_in(p, "the hash in its head is not that of its simplices");
        }
    }
    free(chosen);
    return status == PBW_ERROR_MEMORY ? fault_in(p, "out of memory, or a corner or link is out of range")
         : explain(p->j, status);
}

/* ---- facets and neighbours ---- */

static int check_chunk(proof *p)                     /* once the bytes of all chunks are known to be right */
{
    const size_t count = (size_t)p->view[p->chunk].chunk->simplices;
    const char *fault = NULL;
    size_t s;
    const pbw_status status = pbw_for(&p->j->build, count, 4096, check_range, p);
    collect_ids(p);
    for (s = 0; s < count && status == PBW_ERROR_ARGUMENT && fault == NULL; s++) {
        fault = check_simplex(p, s);
    }
    return fault != NULL ? fault_in(p, fault) : status != PBW_OK ? explain(p->j, status) : add_hash(p);
}

/* ---- the hull, points ---- */

static int compare_facets(const void *a, const void *b)
{
    const hull_facet *x = (const hull_facet *)a, *y = (const hull_facet *)b;
    int k;
    for (k = 0; k < 3; k++) {
        if (x->key[k] != y->key[k]) {
            return x->key[k] < y->key[k] ? -1 : 1;
        }
    }
    return 0;
}

/* Are the facets without a link those of the hull of their vertices?  keys, x, w: of those vertices. */
static int compare_hull(proof *p, const uint64_t *keys, const double *x, const double *w, size_t count)
{
    hull_facet *expected;
    pbw_mesh mesh;
    size_t i, k, m, n = 0;
    int failed;
    pbw_status status = pbw_triangulate((int)p->dim, x, w, count, &p->j->build, &mesh);
    if (status != PBW_OK) {
        return status == PBW_DEGENERATE ? fail(p->j, "the facets without a link are flat") : explain(p->j, status);
    }
    expected = (hull_facet *)calloc(p->facet_count + 1, sizeof *expected);
    for (i = 0; i < mesh.simplex_count * p->corners && expected != NULL && n <= p->facet_count; i++) {
        if (mesh.neighbors[i] == PBW_NONE && n < p->facet_count) {
            for (k = m = 0; k < p->corners; k++) {
                if (k != i % p->corners) {
                    expected[n].key[m++] = keys[mesh.simplices[i / p->corners * p->corners + k]];
                }
            }
            qsort(expected[n].key, p->dim, sizeof(uint64_t), compare_keys);
        }
        n += mesh.neighbors[i] == PBW_NONE;
    }
    qsort(p->facets, p->facet_count, sizeof *p->facets, compare_facets);
    if (expected != NULL && n == p->facet_count) {
        qsort(expected, n, sizeof *expected, compare_facets);
    }
    failed = expected == NULL ? fail(p->j, "out of memory: the hull")
           : n != p->facet_count || memcmp(expected, p->facets, n * sizeof *expected) != 0
           ? fail(p->j, "the facets without a link are not the hull") : 0;
    free(expected);
    pbw_free(&mesh);
    return failed;
}

static int check_hull(proof *p)
{
    size_t c, i, n = 0, count = 0;
    double *x, *w;
    uint64_t *keys;
    int failed;
    for (c = 0; c < p->file.header->tiles; c++) {
        for (i = 0; i < p->view[c].chunk->own; i++) {
            count += (p->seen[c][i] & ON_HULL) != 0;
        }
    }
    x = (double *)malloc((count + 1) * p->dim * sizeof *x);
    w = (double *)malloc((count + 1) * sizeof *w);
    keys = (uint64_t *)malloc((count + 1) * sizeof *keys);
    failed = x == NULL || w == NULL || keys == NULL ? fail(p->j, "out of memory: the hull") : 0;
    for (c = 0; c < p->file.header->tiles && !failed; c++) {
        for (i = 0; i < p->view[c].chunk->own; i++) {
            if (p->seen[c][i] & ON_HULL) {
                const double *point = point_of(p, c, (uint32_t)i);
                memcpy(x + n * p->dim, point, p->dim * sizeof *x);
                w[n] = point[p->dim];
                keys[n++] = (uint64_t)c << 32 | i;
            }
        }
    }
    failed = failed ? failed : compare_hull(p, keys, x, p->file.header->flags & PBWTF_WEIGHTS ? w : NULL, n);
    free(x);
    free(w);
    free(keys);
    return failed;
}

/* Whether no two of the ids that share a bit are equal. */
static int check_ids(const proof *p)
{
    size_t i;
    qsort(p->ids, p->id_count, sizeof *p->ids, compare_keys);
    for (i = 1; i < p->id_count; i++) {
        if (p->ids[i - 1] == p->ids[i]) {
            return fail(p->j, "two points have the id %.0f", (double)p->ids[i]);
        }
    }
    return 0;
}

/* Counts, and that each point is a corner. */
static int check_points(const proof *p, size_t *hidden)
{
    const pbwtf_header *header = p->file.header;
    size_t c, i;
    *hidden = 0;
    for (c = 0; c < header->chunks; c++) {
        for (i = 0; i < p->view[c].chunk->own; i++) {
            *hidden += !(p->seen[c][i] & CORNER);
        }
    }
    if (p->facet_count != header->hull) {
        return fail(p->j, "the counts in the header are wrong");
    }
    return *hidden > 0 && !(header->flags & PBWTF_WEIGHTS) && header->simplices > 0
         ? fail(p->j, *hidden == 1 ? "%zu point is no corner" : "%zu points are no corners", *hidden) : 0;
}

/* The hash of all chunks, which have been added. */
static int compare_hash(const proof *p)
{
    return (p->file.header->points > 0 ? pbw_hash_of(&p->sums) : 0) == p->file.header->hash ? 0
         : fail(p->j, "%s: the hash is not that of its simplices", p->j->input);
}

/* ---- commands ---- */

/* Whether the counts in the header are those of all chunks. */
static int counts_agree(const proof *p)
{
    const pbwtf_header *header = p->file.header;
    uint64_t points = header->duplicates, duplicates = 0;
    size_t c;
    for (c = 0; c < header->chunks; c++) {
        points += p->view[c].chunk->own;
        duplicates += p->view[c].chunk->duplicates;
    }
    return points == header->points && duplicates == header->duplicates;
}

static int open_proof(job *j, proof *p)
{
    char error[PBWTF_ERROR];
    size_t c;
    memset(p, 0, sizeof *p);
    p->j = j;
    if (pbwtf_open(j->input, NULL, &p->file, error) != PBW_OK) {
        return fail(j, "%s", error);
    }
    p->dim = p->file.header->dim;
    p->corners = p->dim + 1;
    p->view = (pbwtf_view *)calloc(p->file.header->chunks + 1, sizeof *p->view);
    p->head = (pbwtf_chunk *)calloc(p->file.header->chunks + 1, sizeof *p->head);
    p->seen = (unsigned char **)calloc(p->file.header->chunks + 1, sizeof *p->seen);
    if (p->view == NULL || p->head == NULL || p->seen == NULL) {
        return fail(j, "out of memory");
    }
    for (c = 0; c < p->file.header->chunks; c++) {
        if (pbwtf_view_head(&p->file, c, p->view + c, error) != PBW_OK) {
            return fail(j, "%s: %s", j->input, error);
        }
        p->head[c] = *p->view[c].chunk;
        p->view[c].chunk = p->head + c;
        p->seen[c] = (unsigned char *)calloc((size_t)p->view[c].chunk->own + 1, 1);
        if (p->seen[c] == NULL) {
            return fail(j, "out of memory");
        }
    }
    if (!counts_agree(p)) {
        return fail(j, "%s: the counts in the header are not those of the tiles", j->input);
    }
    report_line(j, "%zu point%s in %uD%s, %zu %s in %zu tile%s%s, hash %016llx", COUNT(p->file.header->points),
                p->file.header->dim, p->file.header->flags & PBWTF_WEIGHTS ? ", weighted" : "",
                (size_t)p->file.header->simplices, simplices(0, (size_t)p->file.header->simplices),
                COUNT(p->file.header->tiles),
                p->file.header->chunks > p->file.header->tiles ? " and one of leftovers" : "",
                (unsigned long long)p->file.header->hash);
    return 0;
}

static int close_proof(proof *p, int failed)
{
    size_t c;
    for (c = 0; p->seen != NULL && c < p->file.header->chunks; c++) {
        free(p->seen[c]);
    }
    free(p->seen);
    free(p->view);
    free(p->head);
    free(p->facets);
    free(p->once);
    free(p->ids);
    pbwtf_close(&p->file);
    return failed;
}

int check_pbwt(job *j)
{
    proof p;
    double start = now();
    size_t hidden = 0;
    int failed = open_proof(j, &p);
    if (!failed && !(p.file.header->flags & PBWTF_LINKS)) {
        failed = fail(j, "%s: it has no links, so it cannot be proved; pbw hash compares it", j->input);
    }
    failed = failed ? failed : read_chunks(&p);
    failed = failed ? failed : for_chunks(&p, check_chunk);
    failed = failed ? failed : check_ids(&p);
    failed = failed ? failed : check_points(&p, &hidden);
    failed = failed || p.facet_count == 0 ? failed : check_hull(&p);
    failed = failed ? failed : compare_hash(&p);
    if (!failed && pbwtf_fault(&p.file.map) != NULL) {
        failed = fault_in(&p, "");
    }
    if (!failed) {
        report_step(j, "check", now() - start, "valid%s", hidden > 0 ? "; that hidden points are hidden is not "
                    "proved" : "");
    }
    return close_proof(&p, failed);
}

int convert_pbwt(job *j, pbw_mesh *mesh)
{
    proof p;
    const size_t tile = (size_t)number_of(j, "--tile", 0);
    int failed = open_proof(j, &p);
    pbw_status status;
    if (!failed && tile >= p.file.header->chunks) {
        failed = fail(j, "--tile %lu: there are %u", (unsigned long)tile, p.file.header->chunks);
    }
    p.chunk = tile;
    if (!failed) {
        fetch_chunk(&p);
        failed = check_bytes(&p);
    }
    status = failed ? PBW_OK : pbwtf_mesh(p.view + tile, &j->build, mesh);
    if (status != PBW_OK) {
        failed = fail(j, "tile %lu: %s", (unsigned long)tile, status == PBW_ERROR_MEMORY ? "out of memory"
                      : "a corner or a link is out of range");
    }
    return close_proof(&p, failed);
}

static int run_hash(job *j)
{
    proof p;
    int failed;
    if (!is_pbwt(j)) {
        failed = load(j, 1);
        failed = failed ? failed : build(j);
        if (!failed) {
            printf("%016llx\n", (unsigned long long)pbw_hash(&j->mesh, &j->build));
        }
        return failed;
    }
    failed = open_proof(j, &p);
    failed = failed ? failed : for_chunks(&p, add_hash);
    failed = failed ? failed : compare_hash(&p);
    if (!failed) {
        printf("%016llx\n", (unsigned long long)p.file.header->hash);
    }
    return close_proof(&p, failed);
}

const command command_hash = {
    .name = "hash",
    .summary = "one number for a triangulation",
    .usage =
    "usage: pbw hash [options] input\n"
    "\n"
    "Prints the hash of the triangulation: equal for two files if they are the same triangulation of the same\n"
    "points, in any order.  Of a .pbwt file it is computed again, tile by tile, and compared with the header's.\n"
    "\n"
    "input:   as for pbw mesh, or .pbwt\n"
    "\n",
    .options = { input_options, weight_options, build_options, common_options, NULL },
    .run = run_hash,
    .may_be_flat = 1,
};
