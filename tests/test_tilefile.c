/* test_tilefile.c: files of tiles, by the functions of the pbw program itself in one process: a file that differs in
   any word from what was written is refused by every reader to whom that word means something; so are scratch files
   of a run that goes on, files that are truncated while they are read, and a second run in one folder. */
#include "pbw_tilefile.h"
#include "pbw_io.h"
#include "inputs.h"
#include "meter.h"
#include "test.h"
#include <dirent.h>
#include <sys/wait.h>
#include "../examples/program/pbwt.c"
#include "../examples/program/tiles.c"
#include <stdarg.h>

/* ---- what the program has in its other files: options by name, and texts that are kept instead of printed */

extern int truncate(const char *name, off_t length);  /* strict C modes hide it */
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

void warn(const job *j, const char *format, ...)
{
    va_list list;
    (void)j;
    va_start(list, format);
    keep(format, list);
    va_end(list);
}

static void (*on_line)(void), (*on_tile_end)(void);  /* what happens meanwhile: once a file is open, a tile written */

void report_line(const job *j, const char *format, ...)
{
    va_list list;
    (void)j;
    va_start(list, format);
    keep(format, list);
    va_end(list);
    if (on_line != NULL) {
        on_line();
    }
}

void begin(const job *j, const char *name, const char *what)
{
    (void)j;
    (void)name;
    (void)what;
}

void report_step(const job *j, const char *what, double seconds, const char *format, ...)
{
    (void)j;
    (void)seconds;
    (void)format;
    if (on_tile_end != NULL && strcmp(what, "tile") == 0) {
        on_tile_end();
    }
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
int explain(const job *j, pbw_status status)
{
    return status == PBW_OK ? 0 : fail(j, "%s", pbw_status_string(status));
}

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

static size_t memory_limit;
static long stop_at;                                 /* the call of progress that stops the run; 0: none */

static int on_progress(void *user, pbw_stage stage, double done)
{
    (void)user;
    (void)stage;
    (void)done;
    interrupted = interrupted || (stop_at > 0 && --stop_at == 0);
    return interrupted;
}

static int make_tiles(const char *const *options)
{
    job j;
    memset(&j, 0, sizeof j);
    j.output[0] = path;
    j.outputs = 1;
    j.build.threads = 1;
    j.build.progress = on_progress;
    j.build.memory_limit = memory_limit;
    interrupted = 0;
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
    const uint64_t hash = !failed && for_chunks(&p, add_hash) == 0 && compare_hash(&p) == 0 ? p.file.header->hash : 0;
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
            if (k % 5 != 0) {
                continue;
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
    pbwtf_file file;
    size_t c, i;
    put(path, old, size);
    CHECK_EQUAL(pbwtf_open(path, NULL, &file, error), PBW_OK);
    for (c = 0; c < head(old)->chunks; c++) {
        CHECK_EQUAL(pbwtf_view_of(&file, c, &view, error), PBW_OK);
        for (i = 0; i < view.chunk->foreign; i++) {
            char *record = data + ((const char *)(view.foreign + i * view.foreign_size) - file.map.data);
            uint64_t key;
            memcpy(&key, record + 8 * view.own_size, 8);
            if (key == point) {
                memcpy(record + 8 * view.own_size - 8, &id, 8);
            }
        }
        if (c == 0) {
            memcpy(data + ((const char *)(view.own + (point + 1) * view.own_size - 1) - file.map.data), &id, 8);
        }
    }
    pbwtf_close(&file);
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

/* ---- memory */

/* Opens the file and makes a mesh of tile 1, with the options.  Nothing is held afterwards. */
static pbw_status open_tile(const pbw_options *options, const meter *m)
{
    pbwtf_file file;
    pbwtf_view view;
    pbw_mesh mesh;
    char error[PBWTF_ERROR] = "";
    pbw_status status = pbwtf_open(path, options, &file, error);
    if (status == PBW_OK) {
        CHECK_EQUAL(pbwtf_view_of(&file, 9, &view, error), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbwtf_view_of(&file, 1, &view, error), PBW_OK);
        status = pbwtf_mesh(&view, options, &mesh);
        CHECK((status == PBW_OK) == (mesh.simplex_count == view.chunk->simplices && mesh.points != NULL));
        pbwtf_mesh_free(&mesh);
        pbwtf_close(&file);
    } else {
        CHECK(strstr(error, "out of memory") != NULL);
    }
    CHECK(m->blocks == 0 && m->faults == 0);
    return status;
}

static void test_memory(void)
{
    if (test_begin("each allocation of a reader failing, and the limit of memory")) {
        pbw_options options;
        meter m;
        pbw_status status;
        long k = 0;
        size_t most;
        memset(&options, 0, sizeof options);
        options.resize = meter_resize;
        options.resize_user = &m;
        make_file(INPUT_UNIFORM, 3, 300, "3");
        do {
            meter_start(&m, ++k, 0);
            status = open_tile(&options, &m);
            CHECK_EQUAL(status, m.refused > 0 ? PBW_ERROR_MEMORY : PBW_OK);
        } while (m.refused > 0);
        CHECK(k > 3);
        most = m.peak;
        options.memory_limit = most;
        meter_start(&m, 0, 0);
        CHECK_EQUAL(open_tile(&options, &m), PBW_OK);
        for (options.memory_limit = 1; options.memory_limit < most; options.memory_limit += 1 + most / 50) {
            meter_start(&m, 0, 0);
            (void)open_tile(&options, &m);
            CHECK(m.peak <= 2 * options.memory_limit);           /* a mesh has a limit of its own */
        }
        options.memory_limit = 100;
        CHECK_EQUAL(open_tile(&options, &m), PBW_ERROR_MEMORY);
        test_end();
    }
}

/* ---- while they are read */

static size_t cut_to;                                /* bytes; 1: another file comes under the name */

static void cut_file(void)
{
    if (cut_to != 1) {
        CHECK(truncate(path, (off_t)cut_to) == 0);
    } else {
        CHECK(remove(path) == 0);
        fclose(fopen(path, "wb"));
    }
}

static void test_truncation(void)
{
    if (test_begin("files that are truncated or replaced while they are read")) {
        size_t i;
        make_file(INPUT_UNIFORM, 3, 3000, "3");
        for (i = 0; i < 12; i++) {
            cut_to = i < 2 ? i : size * i / 12;
            on_line = cut_file;
            CHECK(checked() == FAILURE && strstr(said, "truncated or replaced") != NULL);
            on_line = NULL;
            remove(path);
            fclose(fopen(path, "wb"));
            put(path, old, size);
            on_line = cut_file;
            cut_to = cut_to < 4096 ? cut_to : 4096;
            CHECK(hashed() == 0 && strstr(said, "truncated or replaced") != NULL);
            on_line = NULL;
            remove(path);
            fclose(fopen(path, "wb"));
            put(path, old, size);
            on_line = cut_file;
            CHECK(converted() == 0 && strstr(said, "truncated or replaced") != NULL);
            on_line = NULL;
            remove(path);
            fclose(fopen(path, "wb"));
            put(path, old, size);
        }
        CHECK_EQUAL(checked(), 0);
        test_end();
    }
}

/* ---- scratch files */

static const char *const three_tiles[] = { "--tiles", "3", "--work", "1", NULL };
static char scratch_folder[100];
static int tiles_ended, stop_after;

static void stop_then(void)
{
    interrupted = ++tiles_ended == stop_after;
}

/* A run that is stopped after so many tiles, or by a call of progress. */
static void stopped_run(int tiles, long call)
{
    tiles_ended = 0;
    stop_after = tiles;
    stop_at = call;
    on_tile_end = stop_then;
    CHECK(make_tiles(three_tiles) == FAILURE && strstr(said, "the same command goes on") != NULL);
    on_tile_end = NULL;
    stop_at = 0;
}

/* The names of scratch files that are not empty, and of the output that grows; returns how many. */
static size_t scratch_names(char (*name)[400])
{
    DIR *list = opendir(scratch_folder);
    const char *slash = strrchr(path, '/');
    struct dirent *entry;
    struct stat about;
    size_t count = 0;
    while (list != NULL && (entry = readdir(list)) != NULL) {
        snprintf(name[count], 400, "%s/%s", scratch_folder, entry->d_name);
        count += stat(name[count], &about) == 0 && S_ISREG(about.st_mode) && about.st_size > 0;
    }
    CHECK(list != NULL && closedir(list) == 0);
    list = opendir("/tmp");
    while (list != NULL && (entry = readdir(list)) != NULL) {
        if (strstr(entry->d_name, ".part.") != NULL && strncmp(entry->d_name, slash + 1, strlen(slash + 1)) == 0) {
            snprintf(name[count++], 400, "/tmp/%s", entry->d_name);
        }
    }
    closedir(list);
    return count;
}

static void flip(const char *name, size_t place)     /* a bit, at so many sixteenths of the file */
{
    FILE *file = fopen(name, "rb+");
    long at;
    int byte;
    CHECK(file != NULL && fseek(file, 0, SEEK_END) == 0);
    at = ftell(file);
    at = place == 16 ? at - 1 : at * (long)place / 16;
    CHECK(fseek(file, at, SEEK_SET) == 0 && (byte = getc(file)) != EOF && fseek(file, at, SEEK_SET) == 0
          && putc(byte ^ 1 << place % 8, file) != EOF && fclose(file) == 0);
}

static int is_as_it_was(void)
{
    size_t count;
    char *now_there = get(path, &count);
    const int same = count == size && memcmp(now_there, old, size) == 0;
    free(now_there);
    return same;
}

/* Returns how many of the flips were told; the others were made good. */
static size_t flips(int tiles, long call, size_t *all)
{
    char name[40][400];
    size_t i, k, n = 1, told = 0;
    for (i = 0; i < n; i++) {
        for (k = 0; k <= 16; k += 8u << (tiles == 3)) {
            remove(path);
            stopped_run(tiles, call);
            n = scratch_names(name);
            flip(name[i], k);
            if (make_tiles(three_tiles) != 0) {
                told += (size_t)CHECK(strstr(said, scratch_folder) != NULL && strstr(said, "start again") != NULL);
                CHECK(access(scratch_folder, F_OK) != 0 && access(path, F_OK) != 0);
                CHECK_EQUAL(make_tiles(three_tiles), 0);
            }
            ++*all;
            if (!CHECK(is_as_it_was())) {
                test_say("%s, %lu sixteenths: %s", name[i], (unsigned long)k, said);
            }
            CHECK(access(scratch_folder, F_OK) != 0);
        }
    }
    CHECK(n > 6);
    return told;
}

static void test_flips(int kind, int dim)
{
    if (test_begin("a flipped bit in each scratch file: kind %d in %dD", kind, dim)) {
        size_t all = 0, told;
        make_file(kind, dim, 200, "3");
        told = flips(kind == INPUT_SPHERE ? 3 : 2, 0, &all);         /* of the sphere there are leftovers to make */
        CHECK(told > 3 && told < all);
        test_end();
    }
}

static void test_points_flipped(void)
{
    if (test_begin("a flipped bit in points of a tile")) {
        size_t all = 0;
        make_file(INPUT_UNIFORM, 3, 500, "3");
        CHECK(flips(0, 2, &all) > 3);
        test_end();
    }
}

static void cut_tree(void)
{
    char name[200];
    snprintf(name, sizeof name, "%s/2.tree", scratch_folder);
    CHECK(tiles_ended++ > 0 || truncate(name, 100) == 0);
}

static void test_cut_tree(void)
{
    if (test_begin("a scratch file that is truncated while it is read")) {
        make_file(INPUT_UNIFORM, 3, 3000, "3");
        tiles_ended = 0;
        on_tile_end = cut_tree;
        memory_limit = 1000000;                      /* so that trees leave memory */
        CHECK(make_tiles(three_tiles) == FAILURE && strstr(said, "2.tree: it was truncated") != NULL);
        on_tile_end = NULL;
        memory_limit = 0;
        CHECK(make_tiles(three_tiles) == 0 && is_as_it_was());
        test_end();
    }
}

static void run_another(void)
{
    const pid_t child = fork();
    char text[60];
    int status = 0;
    if (child == 0) {
        on_tile_end = NULL;
        status = make_tiles(three_tiles);
        snprintf(text, sizeof text, "is in use: process %ld works there", (long)getppid());
        _exit(status == FAILURE && strstr(said, text) != NULL ? 0 : 1);
    }
    CHECK(child > 0 && waitpid(child, &status, 0) == child && status == 0);
}

static void die(void)
{
    _exit(9);
}

static void test_lock(void)
{
    if (test_begin("a second run in a folder; the first one died; files of others")) {
        char name[200];
        FILE *file;
        pid_t child;
        int status = 0;
        make_file(INPUT_UNIFORM, 3, 300, "3");
        on_tile_end = run_another;
        CHECK(make_tiles(three_tiles) == 0 && is_as_it_was());
        on_tile_end = die;
        child = fork();
        if (child == 0) {
            make_tiles(three_tiles);
        }
        CHECK(child > 0 && waitpid(child, &status, 0) == child && status != 0 && access(scratch_folder, F_OK) == 0);
        on_tile_end = NULL;
        CHECK(make_tiles(three_tiles) == 0 && strstr(said, "going on: 1 of 3") != NULL && is_as_it_was());
        snprintf(name, sizeof name, "%s/1.facets", scratch_folder);
        CHECK(mkdir(scratch_folder, 0777) == 0);
        file = fopen(name, "w");
        CHECK(file != NULL && fclose(file) == 0);
        CHECK(make_tiles(three_tiles) == FAILURE && strstr(said, "files of other programs") != NULL);
        CHECK(access(name, F_OK) == 0 && remove(name) == 0);
        CHECK(make_tiles(three_tiles) == 0 && is_as_it_was());
        test_end();
    }
}

int main(int argc, char **argv)
{
    char name[64];
    test_start(argc, argv, 1);
    snprintf(name, sizeof name, "/tmp/test_tilefile.%ld.pbwt", (long)getpid());
    path = name;
    snprintf(scratch_folder, sizeof scratch_folder, "%s.scratch", path);
    test_words(INPUT_UNIFORM, 3, "3", 0);
    test_words(INPUT_UNIFORM, 2, "2", 0);
    test_words(INPUT_SPHERE, 3, "2", 1);
    test_contents();
    test_truncation();
    test_memory();
    test_flips(INPUT_UNIFORM, 3);
    test_flips(INPUT_SPHERE, 3);
    test_points_flipped();
    test_cut_tree();
    test_lock();
    remove(path);
    free(cloud.points);
    free(old);
    free(data);
    return test_finish();
}
