/* test_tilefile.c: files of tiles, by the functions of the pbw program itself in one process: a file that differs in
   any word from what was written is refused by every reader to whom that word means something. */
#define PBW_TILES_IMPLEMENTATION
#define PBW_TILEFILE_IMPLEMENTATION
#define PBW_IO_IMPLEMENTATION
#include "pbw_tilefile.h"
#include "pbw_io.h"
#include "inputs.h"
#include "test.h"
#define run run_hash                                 /* both files have a function of that name */
#include "../examples/program/pbwt.c"
#undef run
#define run run_tiles
#include "../examples/program/tiles.c"
#undef run
#include <stdarg.h>

/* ---- what the program has in its other files: options by name, and texts that are kept instead of printed */

static const char *const *given_options;             /* names and values in turn, NULL ends them */
static char said[20000];

static void keep(const char *format, va_list list)
{
    const size_t length = strlen(said);
    vsnprintf(said + length, sizeof said - length, format, list);
}

int fail(const job *j, const char *format, ...)
{
    va_list list;
    (void)j;
    va_start(list, format);
    keep(format, list);
    va_end(list);
    return FAILURE;
}

int complain(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    keep(format, list);
    va_end(list);
    return USAGE;
}

void note(const job *j, const char *format, ...)
{
    va_list list;
    (void)j;
    va_start(list, format);
    keep(format, list);
    va_end(list);
}

void say(const job *j, const char *what, double seconds, const char *format, ...)
{
    (void)j;
    (void)what;
    (void)seconds;
    (void)format;
}

const char *text_of(const job *j, const char *name)
{
    const char *const *at = given_options;
    (void)j;
    while (at != NULL && *at != NULL && strcmp(*at, name) != 0) {
        at += 2;
    }
    return at != NULL && *at != NULL ? at[1] : NULL;
}

double number_of(const job *j, const char *name, double otherwise)
{
    return text_of(j, name) != NULL ? atof(text_of(j, name)) : otherwise;
}

volatile sig_atomic_t interrupted;
const option input_options[1], weight_options[1], build_options[1], output_options[1], common_options[1];
int is_given(const job *j, const char *name) { return text_of(j, name) != NULL; }
int stopped(const job *j) { return fail(j, "interrupted"); }
int explain(const job *j, pbw_status status) { return status == PBW_OK ? 0 : fail(j, "%s", pbw_status_string(status)); }
const char *plural(size_t count) { return count == 1 ? "" : "s"; }
const char *simplices(int dim, size_t count) { return dim > 0 && count > 0 ? "" : "simplices"; }
double now(void) { return 0; }
int draw_bar(const job *j, const char *name, double done) { return j == NULL || name == NULL || done < 0; }
int build(job *j) { return fail(j, "build"); }

/* ---- files: made, changed in memory, read */

static const char *path;                             /* of the file under test */
static pbwio_cloud cloud;                            /* its points */
static char *data, *old;                             /* what is in the file, and what was written */
static size_t size;

int load(job *j, int flat)
{
    j->cloud = cloud;
    return flat ? 0 : FAILURE;
}

static void put(const char *name, const void *bytes, size_t count)
{
    FILE *file = fopen(name, "rb+");                 /* it is there, and as long: in place is much faster */
    CHECK(file != NULL && fwrite(bytes, 1, count, file) == count && fclose(file) == 0);
}

static char *get(const char *name, size_t *count)
{
    FILE *file = fopen(name, "rb");
    char *bytes = (char *)malloc((size_t)1 << 22);
    *count = file != NULL && bytes != NULL ? fread(bytes, 1, (size_t)1 << 22, file) : 0;
    CHECK(file != NULL && fclose(file) == 0);
    return bytes;
}

static int make_tiles(const char *const *options)
{
    job j;
    memset(&j, 0, sizeof j);
    j.output[0] = path;
    j.outputs = 1;
    j.build.threads = 1;
    given_options = options;
    *said = 0;
    return run_tiles(&j);
}

static void make_points(int kind, int dim, size_t count)
{
    free(cloud.points);
    cloud.dim = dim;
    cloud.count = count;
    cloud.points = (double *)malloc(count * (size_t)dim * sizeof(double));
    input_fill(kind, dim, count, test_seed, cloud.points);
}

/* Writes a file of points of a kind, in so many tiles, and gets its bytes. */
static void make_file(int kind, int dim, size_t count, const char *tiles)
{
    const char *options[] = { "--tiles", NULL, "--work", "1", NULL };
    options[1] = tiles;
    make_points(kind, dim, count);
    CHECK_EQUAL(make_tiles(options), 0);
    free(old);
    free(data);
    old = get(path, &size);
    data = get(path, &size);
}

static job reader(void)
{
    static const char *const tile[] = { "--tile", "1", NULL };
    job j;
    memset(&j, 0, sizeof j);
    j.input = path;
    j.build.threads = 1;
    given_options = tile;
    *said = 0;
    return j;
}

/* The simplices of tile 1 as pbw convert has them; 0: refused. */
static uint64_t converted(void)
{
    job j = reader();
    pbw_mesh mesh;
    uint64_t sum;
    if (convert_pbwt(&j, &mesh) != 0) {
        return 0;
    }
    sum = 1 + pbw_hash(&mesh, NULL) + mesh.simplex_count + mesh.point_count;
    pbwtf_mesh_free(&mesh);
    return sum;
}

/* pbw hash; 0: refused. */
static uint64_t hashed(void)
{
    job j = reader();
    proof p;
    int failed = open_proof(&j, &p);
    const uint64_t hash = !failed && hash_all(&p) == 0 ? p.file.header->hash : 0;
    close_proof(&p, failed);
    return hash;
}

static int checked(void)
{
    job j = reader();
    return check_pbwt(&j);
}

static pbwtf_header *head(char *bytes) { return (pbwtf_header *)(void *)bytes; }
static pbwtf_entry *entry_of(char *bytes, size_t c)
{
    return (pbwtf_entry *)(void *)(bytes + head(old)->table) + c;
}
static pbwtf_chunk *chunk_of(char *bytes, size_t c)
{
    return (pbwtf_chunk *)(void *)(bytes + entry_of(old, c)->offset);
}

/* Makes all checksums right, so that only what they stand for is wrong. */
static void seal(void)
{
    size_t c;
    for (c = 0; c < head(old)->chunks; c++) {
        pbwtf_chunk *chunk = chunk_of(data, c);
        const size_t across = pbwtf_across_offset(chunk_of(old, c));
        chunk->checksum = pbwtf_checksum(0, chunk + 1, across - sizeof *chunk);
        entry_of(data, c)->across_checksum
            = pbwtf_checksum(0, (char *)chunk + across, (size_t)chunk_of(old, c)->across * 8);
    }
    head(data)->checksum = pbwtf_checksum(0, data, sizeof(pbwtf_header) - 8);
}

/* Every word of some bytes becomes several others; sealed: only the header's checksum is made right. */
static void change_words(size_t at, size_t bytes, int sealed)
{
    static const uint32_t add[] = { 1, 0xffffffffu, 2, 0x80000000u, 0x10000 };
    const uint64_t hash = hashed(), tile = converted();
    size_t i, k;
    CHECK(hash != 0 && tile != 0);
    for (i = at; i < at + bytes; i += 4) {
        for (k = 0; k < 7; k++) {
            uint64_t other;
            uint32_t word, value;
            memcpy(&word, old + i, 4);
            value = k < 5 ? word + add[k] : k == 5 ? 0 : 0xffffffffu;
            if (value == word) {
                continue;
            }
            memcpy(data, old, size);
            memcpy(data + i, &value, 4);
            if (sealed) {
                head(data)->checksum = pbwtf_checksum(0, data, sizeof(pbwtf_header) - 8);
            }
            put(path, data, size);
            if (!CHECK(checked() == FAILURE && *said != 0)) {
                test_say("byte %lu of %lu, %08x, not %08x", (unsigned long)i, (unsigned long)size, value, word);
            }
            other = hashed();
            CHECK(other == hash || (other == 0 && *said != 0));
            other = converted();
            CHECK(other == tile || (other == 0 && *said != 0));
        }
    }
    put(path, old, size);
}

static void test_words(int kind, int dim, const char *tiles, int leftovers)
{
    if (test_begin("every word of header, table and heads: kind %d in %dD", kind, dim)) {
        size_t c;
        make_file(kind, dim, leftovers ? 160 : 40, tiles);
        CHECK_EQUAL(checked(), 0);
        CHECK_EQUAL(head(old)->chunks - head(old)->tiles, leftovers);
        change_words(0, sizeof(pbwtf_header) - 8, 1);
        change_words(sizeof(pbwtf_header) - 8, 8, 0);
        change_words((size_t)head(old)->table, head(old)->chunks * sizeof(pbwtf_entry), 1);
        for (c = 0; c < head(old)->chunks; c++) {
            change_words((size_t)entry_of(old, c)->offset, sizeof(pbwtf_chunk), 1);
        }
        test_end();
    }
}

/* A point of tile 0 and its copies in other tiles get another id. */
static void change_id(size_t point, uint64_t id)
{
    pbwtf_view view;
    char error[PBWTF_ERROR];
    pbwtf_map map;
    size_t c, i;
    memset(&map, 0, sizeof map);
    map.data = data;
    map.size = size;
    for (c = 0; c < head(old)->chunks; c++) {
        CHECK(pbwtf_view_at(&map, head(old), entry_of(old, c), c, &view, error));
        for (i = 0; i < view.chunk->foreign; i++) {
            char *record = (char *)(size_t)(view.foreign + i * view.foreign_size);
            uint64_t key;
            memcpy(&key, record + 8 * view.own_size, 8);
            if (key == point) {
                memcpy(record + 8 * view.own_size - 8, &id, 8);
            }
        }
        if (c == 0) {
            memcpy((char *)(size_t)(view.own + (point + 1) * view.own_size - 1), &id, 8);
        }
    }
}

/* Sealed: says whether check accepts what is in data; text: what it must say. */
static void refused(const char *text)
{
    seal();
    put(path, data, size);
    if (!CHECK(checked() == FAILURE && strstr(said, text) != NULL)) {
        test_say("%s: %s", text, said);
    }
    memcpy(data, old, size);
}

/* What fills up, is there twice, or is moved between counts of one sum, with checksums that are right. */
static void test_contents(void)
{
    if (test_begin("contents that are wrong under right checksums")) {
        pbwtf_chunk *chunk;
        uint32_t *words;
        uint64_t id = 0;
        size_t c, tries = 0, moved = 0;
        make_file(INPUT_UNIFORM, 3, 60, "1");
        memcpy(&id, (char *)(chunk_of(data, 0) + 1) + 32 * 7 + 24, 8);
        change_id(3, id);
        refused("two points have the id");
        change_id(3, (uint64_t)1 << 63);             /* another id is fine: what it was is not in the file */
        change_id(4, (uint64_t)1 << 62);
        seal();
        put(path, data, size);
        CHECK_EQUAL(checked(), 0);
        make_file(INPUT_UNIFORM, 3, 60, "3");
        for (c = 0; c < 20; c++) {                   /* an id above all others: simplices change their tile */
            change_id(c, ~(uint64_t)0);
            seal();
            put(path, data, size);
            moved += checked() != 0 && strstr(said, "belongs to another tile") != NULL;
            memcpy(data, old, size);
        }
        CHECK(moved > 5);
        for (c = 0; c < 3; c++) {                    /* the same size: five own points are as long as four others */
            chunk = chunk_of(data, c);
            chunk->own += 5;
            chunk->foreign -= 4;
            refused("the counts in the header");
        }
        chunk = chunk_of(data, 1);
        words = (uint32_t *)(void *)((char *)(chunk + 1) + chunk->own * 32 + chunk->simplices * 32);
        memcpy(words + 10, words, 40);               /* a point of another tile twice */
        refused("");
        words[8] = 0;                                /* its number there, and its tile: its own tile */
        words[9] = 1;
        refused("");
        for (; tries < 20 && (tries == 0 || chunk_of(old, 1)->given % 2 == 0); tries++) {
            make_file(INPUT_SPHERE, 3, 200 + tries, "3");
        }
        for (c = 0; c + 1 < head(old)->chunks; c++) {
            chunk = chunk_of(data, c);
            words = (uint32_t *)(void *)((char *)chunk + pbwtf_across_offset(chunk)) - 1;
            if (chunk->given % 2 != 0) {             /* one more fits where it is filled up */
                *words = 1;
                refused("the checksum is wrong");    /* or: is not 0 */
                chunk->given++;
                refused("the list of points given up");
                *words = (uint32_t)chunk->own - 1;
                chunk->given++;
                refused("");
            }
        }
        make_file(INPUT_UNIFORM, 2, 41, "2");
        for (c = 0; c < 2; c++) {
            chunk = chunk_of(data, c);
            if (chunk->simplices % 2 != 0) {
                words = (uint32_t *)(void *)((char *)(chunk + 1) + chunk->own * 24) + 6 * chunk->simplices;
                *words = 1;
                refused("the checksum is wrong");
            }
        }
        test_end();
    }
}

int main(int argc, char **argv)
{
    char name[64];
    test_start(argc, argv, 1);
    snprintf(name, sizeof name, "/tmp/test_tilefile.%ld.pbwt", (long)getpid());
    path = name;
    test_words(INPUT_UNIFORM, 3, "3", 0);
    test_words(INPUT_UNIFORM, 2, "2", 0);
    test_words(INPUT_SPHERE, 3, "2", 1);
    test_contents();
    remove(path);
    free(cloud.points);
    free(old);
    free(data);
    return test_finish();
}
