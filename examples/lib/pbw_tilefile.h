/* pbw_tilefile.h - v0.2.0 - files of triangulations in tiles: .pbwt - MIT-0

   QUICK START
   In one source file, define PBW_TILEFILE_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h and pbw_tiles.h, with their implementations in some source file.

       pbwtf_file file;
       pbwtf_view view;
       pbw_mesh mesh;
       char error[PBWTF_ERROR];
       if (pbwtf_open("mesh.pbwt", NULL, &file, error) != PBW_OK) { puts(error); return 1; }
       if (pbwtf_view_of(&file, 7, &view, error) != PBW_OK) { puts(error); return 1; }      // tile 7: pointers
       if (pbwtf_mesh(&view, NULL, &mesh) != PBW_OK) { puts("out of memory"); return 1; }   // as a mesh of its own
       pbwtf_mesh_free(&mesh);
       pbwtf_close(&file);

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>places       beyond 2 GB; names that are new
     >>scratch      folders of scratch files
     >>maps         memory of the size of a file, read where needed
     >>layout       sizes of the parts of a chunk
     >>reading      headers, chunks, meshes
     >>writing      a chunk after the other; the header last

   FUNCTIONS
     pbwtf_map_file       maps a file
     pbwtf_unmap          ends that
     pbwtf_fetch          reads bytes of a mapped file, unless they are there
     pbwtf_fault          what was wrong with the bytes
     pbwtf_fetched        bytes that are in memory
     pbwtf_forget         frees the bytes that are in memory
     pbwtf_expect         the sums that bytes must have
     pbwtf_sum            a sum of bytes, faster than a checksum
     pbwtf_seek           goes to a place of a file, beyond 2 GB
     pbwtf_tell           the place in a file
     pbwtf_create         makes a scratch file beside a file
     pbwtf_enter          locks a folder for one run
     pbwtf_leave          frees the lock
     pbwtf_open           opens a file of tiles
     pbwtf_close          closes it
     pbwtf_view_of        a tile
     pbwtf_view_head      the head of a tile
     pbwtf_view_at        the head of a tile in a file that has no header yet
     pbwtf_is_intact      whether its checksum is right
     pbwtf_checksum       the checksum of bytes
     pbwtf_mesh           a tile as a mesh
     pbwtf_mesh_free      frees it
     pbwtf_begin          begins to write a tile
     pbwtf_emit           writes simplices of it
     pbwtf_end            ends it
     pbwtf_across_offset  where the links across tiles are
     pbwtf_chunk_size     how many bytes a tile has in a file
     pbwtf_seal           completes a file

   FORMAT  little endian, all parts on multiples of 8 bytes, filled up with zeros
     header      128 bytes: pbwtf_header, written last
     chunks      one a tile, in any place; the last may be of leftovers and then has no own points:
       head      128 bytes: pbwtf_chunk
       points    own ones: x, y (, z) (, weight) as doubles, then the id (u64: the number in the input)
       simplices a record each: dim+1 corners (u32: below `own` an own point, else foreign point number - own), then,
                 if there are links, dim+1 of them, across from each corner (u32: below 2^31 a simplex of this chunk,
                 0xffffffff the hull, else 2^31 + a number in `across`)
       foreign   points of other tiles: as own ones, then u64: their tile << 32 | number among its points
       given     u32: own points given up to the leftovers
       across    u64: chunk << 40 | simplex << 2 | corner, or all ones: the hull
     table       a pbwtf_entry for each chunk
   A simplex is in one chunk only, that of the tile of its corner with the smallest id; if that is given up, in the
   leftovers.  Its global number is the first of its chunk plus its number there.  Ids are all different.
   Between header and table there are chunks only.  What has no meaning is zero, and so are, without links, hull,
   across and across_checksum.  Links above 2^31 count from there, in the order of the simplices.
   Checksum of words w: h = 0, then h = (h ^ w) * 0x9e3779b97f4a7c15, h ^= h >> 32 for each; of a chunk: all but its
   head and `across`.
   A reader refuses a file with other counts, places or flags, and a chunk with another head; pbwtf_is_intact compares
   the checksums of a chunk.  pbw check proves the rest.
*/
#ifndef PBW_TILEFILE_H
#define PBW_TILEFILE_H
#include "pbw_tiles.h"
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */
#define PBWTF_ERROR 400                    /* bytes of an error text */
#define PBWTF_WEIGHTS 1u                   /* flags */
#define PBWTF_LINKS 2u

typedef struct pbwtf_header {
    char magic[8];                         /* "PBWT0001" */
    uint32_t dim, flags, chunks, tiles;    /* chunks: tiles, and one more if there are leftovers */
    uint64_t points, duplicates, simplices, hull, hash, table, size;      /* table, size: bytes; hull: facets, 0
                                                                              without links */
    uint64_t spare[5], checksum;           /* checksum: of what is before */
} pbwtf_header;

typedef struct pbwtf_chunk {
    char magic[8];                         /* "PBWTILE1" */
    uint32_t tile, dim, flags, unused;
    uint64_t own, foreign, simplices, given, across;
    uint64_t hull, duplicates;             /* links to the hull; points of the tile that were left out */
    pbw_hash_sums hash;                    /* of its own points and its simplices */
    uint64_t checksum, spare[3];
} pbwtf_chunk;

typedef struct pbwtf_entry { uint64_t offset, size, first_simplex, across_checksum; } pbwtf_entry;

typedef struct pbwtf_map {
    const char *data;                      /* what was fetched is there, else zeros */
    size_t size;
    struct pbwtf__blocks *blocks;          /* private */
} pbwtf_map;

typedef struct pbwtf_file {
    pbwtf_map map;
    const pbwtf_header *header;            /* copies, and what is in the file */
    const pbwtf_entry *table;
} pbwtf_file;

typedef struct pbwtf_view {                /* pointers into a map; records of simplices: corners, links */
    const pbwtf_chunk *chunk;
    const double *own, *foreign;           /* own_size, foreign_size doubles a record; the id is the bits of one */
    const uint32_t *simplices, *given;
    const uint64_t *across;
    size_t own_size, foreign_size, simplex_size;     /* in doubles, doubles, u32 */
    size_t size;                           /* bytes of the chunk */
} pbwtf_view;

typedef struct pbwtf_writer {              /* start with pbwtf_begin */
    FILE *file;
    pbwtf_chunk chunk;
    int64_t start;
    uint32_t half[2];
    int halves, failed;
} pbwtf_writer;

/* A file is read in blocks, at their first use, into private memory: a file that is truncated or replaced
   meanwhile is a fault that pbwtf_fault tells, never a signal.  Any number of threads may fetch
   at once.  Functions that take `error` fail with a text there: PBW_ERROR_MEMORY, or PBW_ERROR_BACKEND if a file
   cannot be read or is damaged.  options: memory_limit and resize, for all that the call and what it makes hold but
   the bytes of the file; NULL = defaults. */
#define PBWTF_BLOCK 32768                  /* bytes */
PBWDEF pbw_status pbwtf_map_file(const char *path, const pbw_options *options, pbwtf_map *map,
                                 char *error);     /* an empty file is fine */
PBWDEF void pbwtf_unmap(pbwtf_map *map);
/* Reads the blocks that have some bytes of map->data, unless they are there.  Returns from.  What cannot be read is
   zeros. */
PBWDEF const void *pbwtf_fetch(const pbwtf_map *map, const void *from, size_t size);
/* Returns NULL, or what went wrong since the file was mapped. */
PBWDEF const char *pbwtf_fault(const pbwtf_map *map);
PBWDEF size_t pbwtf_fetched(const pbwtf_map *map);      /* bytes of the blocks that are there */
PBWDEF void pbwtf_forget(const pbwtf_map *map);    /* frees all blocks; nobody may read meanwhile */
/* The map ends at size, and blocks are compared with these sums of them, which are not copied: others are a fault. */
PBWDEF void pbwtf_expect(pbwtf_map *map, size_t size, const uint64_t *sums);
PBWDEF uint64_t pbwtf_sum(const void *data, size_t size);      /* of whole words; faster than a checksum */
PBWDEF int pbwtf_seek(FILE *file, uint64_t place);              /* from the start, beyond 2 GB; 1: it is there */
PBWDEF int64_t pbwtf_tell(FILE *file);                          /* -1: failed */
/* Creates path.part.PROCESS-NUMBER, which was not there, for reading and writing.  name: that, of `size` bytes. */
PBWDEF FILE *pbwtf_create(const char *path, char *name, size_t size);
/* A folder of scratch files, where one run works at a time.  enter: makes the folder unless it is there, and locks
   the file `lock` in it: *lock, a descriptor; the lock ends with the process.  *is_foreign: the folder was there
   without that file, so that what has names of scratch files may be somebody's.  PBW_ERROR_BACKEND: another process
   works there, or why it failed.  leave: frees the lock; remove_it: the file, and the folder if it is empty, go, too.
   */
PBWDEF pbw_status pbwtf_enter(const char *folder, int *lock, int *is_foreign, char *error);
PBWDEF void pbwtf_leave(const char *folder, int lock, int remove_it);
PBWDEF pbw_status pbwtf_open(const char *path, const pbw_options *options, pbwtf_file *file, char *error);
PBWDEF void pbwtf_close(pbwtf_file *file);
PBWDEF pbw_status pbwtf_view_of(const pbwtf_file *file, size_t chunk, pbwtf_view *view, char *error);
PBWDEF pbw_status pbwtf_view_head(const pbwtf_file *file, size_t chunk, pbwtf_view *view,
                                  char *error);    /* fetch the rest */
/* pbwtf_view_head of a file that has no header yet: dim, flags, chunks and tiles of header and one entry are read. */
PBWDEF pbw_status pbwtf_view_at(const pbwtf_map *map, const pbwtf_header *header, const pbwtf_entry *entry,
                                size_t chunk, pbwtf_view *view, char *error);
/* Returns whether the bytes of a chunk are those that were written, by its checksums, and what fills it up is 0. */
PBWDEF int pbwtf_is_intact(const pbwtf_view *view, const pbwtf_entry *entry);
PBWDEF uint64_t pbwtf_checksum(uint64_t h, const void *data, size_t size);     /* of whole words */
/* Fills points, weights, simplices, neighbors (PBW_NONE at the hull and across), canonical: own points, then foreign.
   PBW_ERROR_MEMORY; PBW_ERROR_ARGUMENT: a corner or a link is out of range. */
PBWDEF pbw_status pbwtf_mesh(const pbwtf_view *view, const pbw_options *options, pbw_mesh *mesh);
PBWDEF void pbwtf_mesh_free(pbw_mesh *mesh);

/* A chunk, from the file's position on: begin, pass pbwtf_emit and the writer to the tile's options, end.  tree may
   be NULL: leftovers, then tile is their number.  1: written, as far as fflush can tell. */
PBWDEF void pbwtf_begin(pbwtf_writer *writer, FILE *file, const pbwt_tree *tree, uint32_t tile, uint32_t flags);
PBWDEF pbw_status pbwtf_emit(void *user, const pbwt_tile *tile, size_t first, size_t count, const uint32_t *corners,
                             const uint32_t *links);
PBWDEF int pbwtf_end(pbwtf_writer *writer, const pbwt_tile *tile, int dim);
PBWDEF size_t pbwtf_across_offset(const pbwtf_chunk *chunk);                   /* in the chunk */
PBWDEF size_t pbwtf_chunk_size(const pbwtf_chunk *chunk);
/* Adds counts and the hash to a header's sums, then completes it (magic, checksum). */
PBWDEF void pbwtf_seal(pbwtf_header *header, const pbw_hash_sums *sums);

#ifdef __cplusplus
}
#endif
#endif /* PBW_TILEFILE_H */

#if defined(PBW_TILEFILE_IMPLEMENTATION) && !defined(PBWTF__IMPLEMENTED)
#define PBWTF__IMPLEMENTED

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#ifdef _WIN32
#include <direct.h>
#include <fcntl.h>
#include <io.h>
#include <process.h>
#include <share.h>
#else
#include <fcntl.h>
#include <unistd.h>
#if defined(__GNUC__)                      /* else files are read at once */
#define PBWTF__IN_BLOCKS 1
#include <sched.h>
#include <sys/mman.h>
#if defined(__linux__) && !defined(MAP_ANONYMOUS)
#include <asm/mman.h>                      /* strict C modes hide it */
#endif
#ifndef MAP_ANONYMOUS
#define MAP_ANONYMOUS MAP_ANON
#endif
#ifndef MAP_NORESERVE
#define MAP_NORESERVE 0
#endif
#endif
#endif

static const char pbwtf__no_memory[] = "out of memory";

/* what: pbwtf__no_memory, or what else is wrong. */
static pbw_status pbwtf__fail(char *error, const char *path, const char *what)
{
    snprintf(error, PBWTF_ERROR, "%s: %s", path, what);
    return what == pbwtf__no_memory ? PBW_ERROR_MEMORY : PBW_ERROR_BACKEND;
}

PBWDEF uint64_t pbwtf_checksum(uint64_t h, const void *data, size_t size)
{
    const char *text = (const char *)data;
    size_t i;
    for (i = 0; i + 8 <= size; i += 8) {
        uint64_t w;
        memcpy(&w, text + i, sizeof w);
        h = (h ^ w) * 0x9e3779b97f4a7c15u;
        h ^= h >> 32;
    }
    return h;
}

PBWDEF uint64_t pbwtf_sum(const void *data, size_t size)
{
    const char *text = size == 0 ? "" : (const char *)data;
    uint64_t lane[4] = { 1, 2, 3, 4 }, w[4];
    size_t at, k;
    for (at = 0; at + sizeof w <= size; at += sizeof w) {            /* lanes do not wait for each other */
        memcpy(w, text + at, sizeof w);
        for (k = 0; k < 4; k++) {
            lane[k] = (lane[k] ^ w[k]) * 0x9e3779b97f4a7c15u;
            lane[k] ^= lane[k] >> 32;
        }
    }
    return pbwtf_checksum(pbwtf_checksum(size, lane, sizeof lane), text + at, size - at);
}

/* ------------------------------------------------------------------------------------------------------
   >>places       Beyond 2 GB; names that are new.
   In: a position in a file, or its name.  Out: the file at that position, or a file that did not exist before.
   ------------------------------------------------------------------------------------------------------ */
PBWDEF int pbwtf_seek(FILE *file, uint64_t place)
{
#if defined(_WIN32)
    return _fseeki64(file, (__int64)place, SEEK_SET) == 0;
#elif defined(__USE_LARGEFILE)                       /* glibc's: fseeko is declared, by _LARGEFILE_SOURCE */
    return fseeko(file, (off_t)place, SEEK_SET) == 0;
#else
    return (uint64_t)(long)place == place && fseek(file, (long)place, SEEK_SET) == 0;
#endif
}

PBWDEF int64_t pbwtf_tell(FILE *file)
{
#if defined(_WIN32)
    return _ftelli64(file);
#elif defined(__USE_LARGEFILE)
    return ftello(file);
#else
    return ftell(file);
#endif
}

PBWDEF FILE *pbwtf_create(const char *path, char *name, size_t size)
{
    FILE *file = NULL;
    unsigned number;
    for (number = 0; file == NULL && (number == 0 || (errno == EEXIST && number < 10000)); number++) {
#ifdef _WIN32
        int open_file;
        snprintf(name, size, "%s.part.%lu-%u", path, (unsigned long)_getpid(), number);
        open_file = _open(name, _O_CREAT | _O_EXCL | _O_RDWR | _O_BINARY, _S_IREAD | _S_IWRITE);
        file = open_file >= 0 ? _fdopen(open_file, "w+b") : NULL;
#else
        snprintf(name, size, "%s.part.%lu-%u", path, (unsigned long)getpid(), number);
        file = fopen(name, "w+bx");
#endif
    }
    return file;
}

/* ------------------------------------------------------------------------------------------------------
   >>scratch      Folders of scratch files.
   In: a folder.  Out: its lock, or the words that say which process has it.
   Holds: one run at a time works in a folder.
   ------------------------------------------------------------------------------------------------------ */
static int pbwtf__in_use(const char *folder, long process, char *error)
{
    char who[40] = "another process";
    if (process > 0) {
        snprintf(who, sizeof who, "process %ld", process);
    }
    snprintf(error, PBWTF_ERROR, "%s is in use: %s works there; wait for it, or name another output", folder, who);
    return 0;
}

static int pbwtf__no_lock(const char *folder, int why, char *error)
{
    (void)pbwtf__fail(error, folder, strerror(why));
    return 0;
}

/* Returns 1 with the lock, 0 with a text, or -1: the run that had it has just removed it. */
#ifdef _WIN32
#define PBWTF__MAKE_FOLDER(path) _mkdir(path)
#define PBWTF__REMOVE_FOLDER(path) _rmdir(path)
static int pbwtf__try_lock(const char *folder, const char *name, int *lock, char *error)
{
    *lock = _sopen(name, _O_RDWR | _O_CREAT | _O_BINARY, _SH_DENYWR, _S_IREAD | _S_IWRITE);
    return *lock >= 0 ? 1 : errno == EACCES ? pbwtf__in_use(folder, 0, error) : pbwtf__no_lock(folder, errno, error);
}
#else
#define PBWTF__MAKE_FOLDER(path) mkdir(path, 0777)
#define PBWTF__REMOVE_FOLDER(path) rmdir(path)
static int pbwtf__try_lock(const char *folder, const char *name, int *lock, char *error)
{
    struct flock range;
    struct stat mine, there;
    *lock = open(name, O_RDWR | O_CREAT, 0666);
    if (*lock < 0) {
        return errno == ENOENT ? -1 : pbwtf__no_lock(folder, errno, error);
    }
    memset(&range, 0, sizeof range);
    range.l_type = F_WRLCK;
    range.l_whence = SEEK_SET;
    if (fcntl(*lock, F_SETLK, &range) != 0) {
        const int why = errno, is_held = why == EACCES || why == EAGAIN;
        const int is_known = is_held && fcntl(*lock, F_GETLK, &range) == 0;
        close(*lock);
        *lock = -1;
        return is_known && range.l_type == F_UNLCK ? -1
             : is_held ? pbwtf__in_use(folder, is_known ? (long)range.l_pid : 0, error)
             : pbwtf__no_lock(folder, why, error);
    }
    if (fstat(*lock, &mine) != 0 || stat(name, &there) != 0 || mine.st_ino != there.st_ino) {
        close(*lock);
        *lock = -1;
    }
    return *lock >= 0 ? 1 : -1;
}
#endif

PBWDEF pbw_status pbwtf_enter(const char *folder, int *lock, int *is_foreign, char *error)
{
    char name[1200];
    struct stat there;
    int result = -1, tries;
    *lock = -1;
    snprintf(name, sizeof name, "%s/lock", folder);
    for (tries = 0; tries < 100 && result < 0; tries++) {
        const int is_made = PBWTF__MAKE_FOLDER(folder) == 0;
        if (!is_made && errno != EEXIST) {
            return pbwtf__fail(error, folder, strerror(errno));
        }
        *is_foreign = !is_made && stat(name, &there) != 0;
        result = pbwtf__try_lock(folder, name, lock, error);
    }
    return result < 0 ? pbwtf__fail(error, folder, "others remove it again and again")
         : result == 0 ? PBW_ERROR_BACKEND : PBW_OK;
}

PBWDEF void pbwtf_leave(const char *folder, int lock, int remove_it)
{
    char name[1200];
    snprintf(name, sizeof name, "%s/lock", folder);
#ifdef _WIN32                              /* cannot remove an open file */
    _close(lock);
#endif
    if (remove_it) {                       /* while it is locked: the next run looks whether it is still there */
        remove(name);
        PBWTF__REMOVE_FOLDER(folder);
    }
#ifndef _WIN32
    close(lock);
#endif
}

/* ------------------------------------------------------------------------------------------------------
   >>maps         Memory of the size of a file, read where needed.
   In: a name.  Out: addresses that have its bytes after pbwtf_fetch.
   Holds: the system has given only what was fetched.  Each block is read by itself, from a file that is opened for
   it: no file stays open, and another one under its name is noticed.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwtf__blocks {
    pbw_memory memory;
    size_t bytes;                                    /* of this, with the path and the states */
    const uint64_t *sums;
    size_t size;                                     /* of the file's memory */
    size_t count;                                    /* of blocks that are there */
    int fault;                                       /* 1: cannot be read; 2: another sum */
    uint64_t device, number;                         /* of the file */
    unsigned char *state;                            /* per block: 0, 1: somebody reads it, 2: it is there */
    char path[1];                                    /* as long as it is, then the states */
} pbwtf__blocks;

#ifdef PBWTF__IN_BLOCKS
#define PBWTF__GET(p) __atomic_load_n(p, __ATOMIC_ACQUIRE)
#define PBWTF__SET(p, value) __atomic_store_n(p, value, __ATOMIC_RELEASE)
#define PBWTF__TAKE(p, none) __atomic_compare_exchange_n(p, none, 1, 0, __ATOMIC_ACQUIRE, __ATOMIC_ACQUIRE)
#define PBWTF__YIELD() sched_yield()
#else                                                /* what two threads write is the same */
#define PBWTF__GET(p) (*(p))
#define PBWTF__SET(p, value) (*(p) = (value))
#define PBWTF__TAKE(p, none) ((void)(none), 1)
#define PBWTF__YIELD() ((void)0)
#endif

static size_t pbwtf__block_count(size_t size)
{
    return (size + PBWTF_BLOCK - 1) / PBWTF_BLOCK;
}

static int pbwtf__blocks_of(const char *path, size_t size, pbw_memory *memory, pbwtf_map *map)
{
    const size_t length = strlen(path) + 1, bytes = sizeof(pbwtf__blocks) + length + pbwtf__block_count(size);
    pbwtf__blocks *b = (pbwtf__blocks *)pbw_memory_resize(memory, NULL, 0, bytes, 1);
    if (b != NULL) {
        memset(b, 0, bytes);
        memcpy(b->path, path, length);
        b->state = (unsigned char *)b->path + length;
        b->memory = *memory;
        b->bytes = bytes;
        b->size = size;
    }
    map->blocks = b;
    map->size = size;
    return b != NULL;
}

static void pbwtf__free_blocks(pbwtf_map *map)
{
    if (map->blocks != NULL) {
        pbw_memory memory = map->blocks->memory;
        (void)pbw_memory_resize(&memory, map->blocks, map->blocks->bytes, 0, 1);
    }
    memset(map, 0, sizeof *map);
}

#ifdef PBWTF__IN_BLOCKS
PBWDEF pbw_status pbwtf_map_file(const char *path, const pbw_options *options, pbwtf_map *map, char *error)
{
    const int file = open(path, O_RDONLY);
    struct stat about;
    pbw_memory memory;
    void *data = NULL;
    const char *what = NULL;
    memset(map, 0, sizeof *map);
    pbw_memory_start(&memory, options);
    if (file < 0 || fstat(file, &about) != 0) {
        what = strerror(errno);
    } else if (!S_ISREG(about.st_mode)) {
        what = "not a regular file";
    } else if (!pbwtf__blocks_of(path, (size_t)about.st_size, &memory, map)) {
        what = pbwtf__no_memory;
    } else if (map->size > 0) {
        data = mmap(NULL, map->size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        what = data == MAP_FAILED ? strerror(errno) : NULL;
    }
    if (file >= 0) {
        close(file);
    }
    if (what != NULL) {
        pbwtf__free_blocks(map);
        return pbwtf__fail(error, path, what);
    }
    map->data = (const char *)data;
    map->blocks->device = (uint64_t)about.st_dev;
    map->blocks->number = (uint64_t)about.st_ino;
    return PBW_OK;
}

static int pbwtf__read_block(const pbwtf_map *map, size_t from, size_t size)
{
    const pbwtf__blocks *b = map->blocks;
    const int file = open(b->path, O_RDONLY);
    char *to = (char *)(size_t)map->data + from;
    struct stat about;
    int good = file >= 0 && fstat(file, &about) == 0 && (uint64_t)about.st_dev == b->device
            && (uint64_t)about.st_ino == b->number && lseek(file, (off_t)from, SEEK_SET) == (off_t)from;
    while (good && size > 0) {
        const ssize_t got = read(file, to, size);
        if (got > 0) {
            to += got;
            size -= (size_t)got;
        } else {
            good = got < 0 && errno == EINTR;
        }
    }
    if (file >= 0) {
        close(file);
    }
    return good;
}

PBWDEF void pbwtf_unmap(pbwtf_map *map)
{
    if (map->data != NULL) {
        munmap((void *)(size_t)map->data, map->blocks->size);
    }
    pbwtf__free_blocks(map);
}

PBWDEF void pbwtf_forget(const pbwtf_map *map)
{
    size_t i, from = 0, count = pbwtf_fetched(map) > 0 ? pbwtf__block_count(map->size) : 0;
    for (i = 0; i <= count; i++) {
        if (i < count && map->blocks->state[i] != 0) {
            map->blocks->state[i] = 0;
        } else {                                     /* a run of blocks ends */
            const size_t begin = from * PBWTF_BLOCK, end = i * PBWTF_BLOCK < map->size ? i * PBWTF_BLOCK : map->size;
            if (end > begin && mmap((void *)(size_t)(map->data + begin), end - begin, PROT_READ | PROT_WRITE,
                                    MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED, -1, 0) == MAP_FAILED) {
                map->blocks->fault = 1;
            }
            from = i + 1;
        }
    }
    if (map->blocks != NULL) {
        map->blocks->count = 0;
    }
}
#else
PBWDEF pbw_status pbwtf_map_file(const char *path, const pbw_options *options, pbwtf_map *map, char *error)
{
    FILE *file = fopen(path, "rb");
    const int64_t size = file != NULL && fseek(file, 0, SEEK_END) == 0 ? pbwtf_tell(file) : -1;
    pbw_memory memory;
    const char *what = NULL;
    char *data = NULL;
    memset(map, 0, sizeof *map);
    pbw_memory_start(&memory, options);
    if (size < 0) {
        what = file == NULL ? strerror(errno) : "cannot read it";
    } else if ((uint64_t)size >= (size_t)-1
               || (data = (char *)pbw_memory_resize(&memory, NULL, 0, (size_t)size + 1, 1)) == NULL) {
        what = pbwtf__no_memory;
    } else {
        rewind(file);
        what = fread(data, 1, (size_t)size, file) != (size_t)size ? "cannot read it"
             : !pbwtf__blocks_of(path, (size_t)size, &memory, map) ? pbwtf__no_memory : NULL;
    }
    if (file != NULL) {
        fclose(file);
    }
    if (what != NULL) {
        if (data != NULL) {
            (void)pbw_memory_resize(&memory, data, (size_t)size + 1, 0, 1);
        }
        memset(map, 0, sizeof *map);
        return pbwtf__fail(error, path, what);
    }
    map->data = data;
    return PBW_OK;
}

static int pbwtf__read_block(const pbwtf_map *map, size_t from, size_t size)
{
    (void)map;
    (void)from;
    (void)size;
    return 1;
}

PBWDEF void pbwtf_unmap(pbwtf_map *map)
{
    if (map->data != NULL) {
        (void)pbw_memory_resize(&map->blocks->memory, (void *)(size_t)map->data, map->blocks->size + 1, 0, 1);
    }
    pbwtf__free_blocks(map);
}

PBWDEF void pbwtf_forget(const pbwtf_map *map)
{
    (void)map;
}
#endif

static void pbwtf__load(const pbwtf_map *map, size_t block)
{
    pbwtf__blocks *b = map->blocks;
    const size_t from = block * PBWTF_BLOCK, size = map->size - from < PBWTF_BLOCK ? map->size - from : PBWTF_BLOCK;
    unsigned char none = 0;
    if (!PBWTF__TAKE(b->state + block, &none)) {
        while (PBWTF__GET(b->state + block) == 1) {
            PBWTF__YIELD();
        }
        return;
    }
    if (!pbwtf__read_block(map, from, size)) {
        PBWTF__SET(&b->fault, 1);
    } else if (b->sums != NULL && pbwtf_sum(map->data + from, size) != b->sums[block]) {
        PBWTF__SET(&b->fault, 2);
    }
    (void)PBW_ATOMIC_ADD(&b->count, 1);
    PBWTF__SET(b->state + block, 2);
}

PBWDEF size_t pbwtf_fetched(const pbwtf_map *map)
{
    return map->blocks != NULL ? PBWTF__GET(&map->blocks->count) * PBWTF_BLOCK : 0;
}

PBWDEF const void *pbwtf_fetch(const pbwtf_map *map, const void *from, size_t size)
{
    const size_t begin = (size_t)((const char *)from - map->data);
    size_t block = begin / PBWTF_BLOCK;
    for (; block * PBWTF_BLOCK < begin + size; block++) {
        if (PBWTF__GET(map->blocks->state + block) != 2) {
            pbwtf__load(map, block);
        }
    }
    return from;
}

PBWDEF const char *pbwtf_fault(const pbwtf_map *map)
{
    const int fault = map->blocks != NULL ? PBWTF__GET(&map->blocks->fault) : 0;
    return fault == 0 ? NULL : fault == 1 ? "it was truncated or replaced while it was read"
         : "it is damaged: a checksum is wrong";
}

PBWDEF void pbwtf_expect(pbwtf_map *map, size_t size, const uint64_t *sums)
{
    map->size = size < map->size ? size : map->size;
    map->blocks->sums = sums;
}

/* ------------------------------------------------------------------------------------------------------
   >>layout       Sizes of the parts of a chunk.
   In: the head of a chunk.  Out: pointers to its parts.
   Holds: parts start on multiples of 8 bytes, and are filled up with zeros.
   ------------------------------------------------------------------------------------------------------ */
static size_t pbwtf__round(size_t bytes)
{
    return (bytes + 7) / 8 * 8;
}

static void pbwtf__sizes(const pbwtf_chunk *chunk, pbwtf_view *view)
{
    view->own_size = (size_t)chunk->dim + (chunk->flags & PBWTF_WEIGHTS ? 1 : 0) + 1;
    view->foreign_size = view->own_size + 1;
    view->simplex_size = ((size_t)chunk->dim + 1) * (chunk->flags & PBWTF_LINKS ? 2 : 1);
}

PBWDEF size_t pbwtf_across_offset(const pbwtf_chunk *chunk)
{
    pbwtf_view view;
    size_t simplices;
    pbwtf__sizes(chunk, &view);
    simplices = pbwtf__round((size_t)chunk->simplices * view.simplex_size * 4);
    return sizeof *chunk + (size_t)chunk->own * view.own_size * 8 + simplices
         + (size_t)chunk->foreign * view.foreign_size * 8 + pbwtf__round((size_t)chunk->given * 4);
}

PBWDEF size_t pbwtf_chunk_size(const pbwtf_chunk *chunk)
{
    return pbwtf_across_offset(chunk) + (size_t)chunk->across * 8;
}

PBWDEF void pbwtf_seal(pbwtf_header *header, const pbw_hash_sums *sums)
{
    memcpy(header->magic, "PBWT0001", 8);
    header->hash = header->points > 0 ? pbw_hash_of(sums) : 0;
    header->checksum = pbwtf_checksum(0, header, sizeof *header - 8);
}

/* ------------------------------------------------------------------------------------------------------
   >>reading      Headers, chunks, meshes.
   In: a file of tiles.  Out: views of its chunks, or an error in words.
   Holds: no number of the file is used before it was compared with the size of the file.
   ------------------------------------------------------------------------------------------------------ */
static int pbwtf__is_zero(const uint64_t *words, size_t count)
{
    uint64_t any = 0;
    for (; count > 0; count--) {
        any |= *words++;
    }
    return any == 0;
}

/* Returns NULL, or what is wrong with a header. */
static const char *pbwtf__header_fault(const pbwtf_header *h, size_t size)
{
    if (size < sizeof *h || memcmp(h->magic, "PBWT0001", 8) != 0) {
        return "no .pbwt file, or one that was not finished";
    }
    if (h->checksum != pbwtf_checksum(0, h, sizeof *h - 8)) {
        return "the header is damaged";
    }
    if (h->size != size || h->table > size || size - h->table != h->chunks * (uint64_t)sizeof(pbwtf_entry)) {
        return "the file is truncated";
    }
    return h->dim < 2 || h->dim > 3 || h->flags > (PBWTF_WEIGHTS | PBWTF_LINKS) || h->table % 8 != 0
        || h->table < sizeof *h || h->tiles == 0 || h->chunks < h->tiles || h->chunks - h->tiles > 1
        || h->duplicates > h->points
        || (h->hull > 0 && !(h->flags & PBWTF_LINKS)) || !pbwtf__is_zero(h->spare, 5) ? "the header is wrong" : NULL;
}

/* Chunks fill all that is between header and table; numbers of simplices ascend from 0. */
static const char *pbwtf__table_fault(const pbwtf_header *h, const pbwtf_entry *table)
{
    uint64_t bytes = sizeof *h, first = 0;
    size_t c;
    for (c = 0; c < h->chunks; c++) {
        if (table[c].size > h->table - bytes || table[c].first_simplex < first || (c == 0 && table->first_simplex > 0)
            || table[c].first_simplex > h->simplices) {
            return "the table of tiles is wrong";
        }
        bytes += table[c].size;
        first = table[c].first_simplex;
    }
    return bytes != h->table ? "the table of tiles is wrong" : NULL;
}

PBWDEF pbw_status pbwtf_open(const char *path, const pbw_options *options, pbwtf_file *file, char *error)
{
    const char *what, *table;
    pbwtf_header header;
    char *copy = NULL;
    size_t size = 0;
    pbw_status status;
    memset(file, 0, sizeof *file);
    memset(&header, 0, sizeof header);
    status = pbwtf_map_file(path, options, &file->map, error);
    if (status != PBW_OK) {
        return status;
    }
    if (file->map.size >= sizeof header) {
        memcpy(&header, pbwtf_fetch(&file->map, file->map.data, sizeof header), sizeof header);
    }
    what = pbwtf__header_fault(&header, file->map.size);
    if (what == NULL) {
        size = header.chunks * sizeof(pbwtf_entry);
        table = (const char *)pbwtf_fetch(&file->map, file->map.data + header.table, size);
        what = pbwtf__table_fault(&header, (const pbwtf_entry *)(const void *)table);
        if (what == NULL) {
            copy = (char *)pbw_memory_resize(&file->map.blocks->memory, NULL, 0, sizeof header + size, 1);
            what = copy == NULL ? pbwtf__no_memory : NULL;
        }
        if (what == NULL) {
            memcpy(copy, &header, sizeof header);
            memcpy(copy + sizeof header, table, size);
            file->table = (const pbwtf_entry *)(const void *)(copy + sizeof header);
        }
    }
    file->header = (const pbwtf_header *)(const void *)copy;
    what = pbwtf_fault(&file->map) != NULL ? pbwtf_fault(&file->map) : what;
    if (what != NULL) {
        pbwtf_close(file);
        return pbwtf__fail(error, path, what);
    }
    return PBW_OK;
}

PBWDEF void pbwtf_close(pbwtf_file *file)
{
    if (file->header != NULL) {
        const size_t bytes = sizeof *file->header + file->header->chunks * sizeof(pbwtf_entry);
        (void)pbw_memory_resize(&file->map.blocks->memory, (void *)(size_t)file->header, bytes, 0, 1);
    }
    pbwtf_unmap(&file->map);
    memset(file, 0, sizeof *file);
}

/* Whether the head of a chunk is one of such a file; counts are below the file's size, so that no sum overflows. */
static int pbwtf__is_head(const pbwtf_chunk *c, const pbwtf_header *h, size_t chunk, uint64_t most)
{
    const int links = (h->flags & PBWTF_LINKS) != 0;
    return memcmp(c->magic, "PBWTILE1", 8) == 0 && c->tile == chunk && c->dim == h->dim && c->flags == h->flags
        && c->unused == 0 && pbwtf__is_zero(c->spare, 3)
        && c->own <= most && c->foreign <= most && c->simplices <= most && c->across <= most && c->given <= c->own
        && (chunk < h->tiles || (c->own == 0 && c->duplicates == 0)) && (links || (c->across == 0 && c->hull == 0));
}

PBWDEF pbw_status pbwtf_view_at(const pbwtf_map *map, const pbwtf_header *header, const pbwtf_entry *entry,
                                size_t chunk, pbwtf_view *view, char *error)
{
    const uint64_t most = map->size;
    const char *at;
    char name[40];
    memset(view, 0, sizeof *view);
    snprintf(name, sizeof name, "tile %lu", (unsigned long)chunk);
    if (entry->offset % 8 != 0 || entry->offset > most || most - entry->offset < sizeof(pbwtf_chunk)) {
        return pbwtf__fail(error, name, "its place in the file is wrong");
    }
    at = map->data + entry->offset;
    view->chunk = (const pbwtf_chunk *)pbwtf_fetch(map, at, sizeof(pbwtf_chunk));
    if (pbwtf_fault(map) != NULL) {
        return pbwtf__fail(error, name, pbwtf_fault(map));
    }
    if (!pbwtf__is_head(view->chunk, header, chunk, most) || pbwtf_chunk_size(view->chunk) != entry->size
        || entry->size > most - entry->offset) {
        return pbwtf__fail(error, name, "its head is damaged");
    }
    pbwtf__sizes(view->chunk, view);
    view->size = (size_t)entry->size;
    at += sizeof(pbwtf_chunk);
    view->own = (const double *)(const void *)at;
    at += view->chunk->own * view->own_size * 8;
    view->simplices = (const uint32_t *)(const void *)at;
    at += pbwtf__round((size_t)view->chunk->simplices * view->simplex_size * 4);
    view->foreign = (const double *)(const void *)at;
    at += view->chunk->foreign * view->foreign_size * 8;
    view->given = (const uint32_t *)(const void *)at;
    at += pbwtf__round((size_t)view->chunk->given * 4);
    view->across = (const uint64_t *)(const void *)at;
    return PBW_OK;
}

PBWDEF pbw_status pbwtf_view_head(const pbwtf_file *file, size_t chunk, pbwtf_view *view, char *error)
{
    const pbwtf_header *header = file->header;
    const pbwtf_entry *entry = file->table + chunk;
    pbw_status status;
    memset(view, 0, sizeof *view);
    if (chunk >= header->chunks) {
        snprintf(error, PBWTF_ERROR, "tile %lu: there are %lu", (unsigned long)chunk, (unsigned long)header->chunks);
        return PBW_ERROR_ARGUMENT;
    }
    status = pbwtf_view_at(&file->map, header, entry, chunk, view, error);
    if (status != PBW_OK) {
        return status;
    }
    if ((chunk + 1 < header->chunks ? entry[1].first_simplex : header->simplices) - entry->first_simplex
        != view->chunk->simplices) {
        snprintf(error, PBWTF_ERROR, "tile %lu: it has %.0f simplices, and other numbers of them in the table",
                 (unsigned long)chunk, (double)view->chunk->simplices);
        return PBW_ERROR_BACKEND;
    }
    return PBW_OK;
}

PBWDEF pbw_status pbwtf_view_of(const pbwtf_file *file, size_t chunk, pbwtf_view *view, char *error)
{
    char name[40];
    const pbw_status status = pbwtf_view_head(file, chunk, view, error);
    if (status != PBW_OK) {
        return status;
    }
    pbwtf_fetch(&file->map, view->chunk, view->size);
    snprintf(name, sizeof name, "tile %lu", (unsigned long)chunk);
    return pbwtf_fault(&file->map) == NULL ? PBW_OK : pbwtf__fail(error, name, pbwtf_fault(&file->map));
}

PBWDEF int pbwtf_is_intact(const pbwtf_view *view, const pbwtf_entry *entry)
{
    const pbwtf_chunk *c = view->chunk;
    const char *after_head = (const char *)view->own;        /* the head may be a copy */
    const size_t words = (size_t)c->simplices * view->simplex_size;
    return pbwtf_checksum(0, after_head, pbwtf_across_offset(c) - sizeof *c) == c->checksum
        && pbwtf_checksum(0, view->across, (size_t)c->across * 8) == entry->across_checksum
        && (words % 2 == 0 || view->simplices[words] == 0) && (c->given % 2 == 0 || view->given[c->given] == 0);
}

/* What pbw_mesh.memory points at; behind it are points, weights, simplices, neighbors, canonical, incident. */
typedef struct pbwtf__block { pbw_memory memory; size_t doubles; } pbwtf__block;

PBWDEF void pbwtf_mesh_free(pbw_mesh *mesh)
{
    if (mesh->memory != NULL) {
        pbwtf__block *block = (pbwtf__block *)mesh->memory;
        pbw_memory memory = block->memory;
        (void)pbw_memory_resize(&memory, block, sizeof *block + block->doubles * sizeof(double), 0, 1);
    }
    memset(mesh, 0, sizeof *mesh);
}

PBWDEF pbw_status pbwtf_mesh(const pbwtf_view *view, const pbw_options *options, pbw_mesh *mesh)
{
    const size_t dim = view->chunk->dim, corners = dim + 1, own = (size_t)view->chunk->own;
    const size_t count = own + (size_t)view->chunk->foreign, simplices = (size_t)view->chunk->simplices;
    const size_t doubles = count * (dim + 2) + simplices * corners + 1;
    pbwtf__block *block;
    pbw_memory memory;
    double *points, *weights;
    pbw_index *index;
    size_t i, k;
    memset(mesh, 0, sizeof *mesh);
    pbw_memory_start(&memory, options);
    block = (pbwtf__block *)pbw_memory_resize(&memory, NULL, 0, sizeof *block + doubles * sizeof(double), 1);
    if (block == NULL) {
        return PBW_ERROR_MEMORY;
    }
    block->memory = memory;
    block->doubles = doubles;
    points = (double *)(void *)(block + 1);
    mesh->memory = block;
    weights = points + count * dim;
    index = (pbw_index *)(void *)(weights + count);
    mesh->dim = (int)dim;
    mesh->point_count = count;
    mesh->simplex_count = simplices;
    mesh->points = points;
    mesh->weights = view->chunk->flags & PBWTF_WEIGHTS ? weights : NULL;
    mesh->simplices = index;
    mesh->neighbors = index + simplices * corners;
    mesh->canonical = index + 2 * simplices * corners;
    mesh->incident = mesh->canonical + count;
    for (i = 0; i < count; i++) {
        const double *p = i < own ? view->own + i * view->own_size : view->foreign + (i - own) * view->foreign_size;
        memcpy(points + i * dim, p, dim * sizeof(double));
        weights[i] = mesh->weights != NULL ? p[dim] : 0;
        index[2 * simplices * corners + i] = (pbw_index)i;
        index[2 * simplices * corners + count + i] = PBW_NONE;
    }
    for (i = simplices; i-- > 0;) {
        const uint32_t *record = view->simplices + i * view->simplex_size;
        for (k = 0; k < corners; k++) {
            const uint32_t link = view->chunk->flags & PBWTF_LINKS ? record[corners + k] : PBW_NONE;
            if (record[k] >= count || (link < 0x80000000u && link >= simplices)) {
                pbwtf_mesh_free(mesh);
                return PBW_ERROR_ARGUMENT;
            }
            index[i * corners + k] = record[k];
            index[(simplices + i) * corners + k] = link < 0x80000000u ? link : PBW_NONE;
            index[2 * simplices * corners + count + record[k]] = (pbw_index)i;
        }
    }
    return PBW_OK;
}

/* ------------------------------------------------------------------------------------------------------
   >>writing      A chunk after the other; the header last.
   In: simplices, as a tile emits them.  Out: a chunk with its checksums; a file that is complete or has no header.
   ------------------------------------------------------------------------------------------------------ */
static void pbwtf__write(pbwtf_writer *w, const void *data, size_t size)
{
    w->failed |= size > 0 && fwrite(data, 1, size, w->file) != size;
}

/* Writes what the checksum counts, a multiple of four bytes; half a word waits for the next. */
static void pbwtf__put(pbwtf_writer *w, const void *data, size_t size)
{
    const char *text = (const char *)data;
    size_t from = 0;
    pbwtf__write(w, data, size);
    while (from < size && (w->halves > 0 || size - from < 8)) {      /* one by one to the end */
        memcpy(w->half + w->halves, text + from, 4);
        from += 4;
        if (++w->halves == 2) {
            w->chunk.checksum = pbwtf_checksum(w->chunk.checksum, w->half, 8);
            w->halves = 0;
        }
    }
    if (size - from >= 8) {
        const size_t whole = (size - from) / 8 * 8;
        w->chunk.checksum = pbwtf_checksum(w->chunk.checksum, text + from, whole);
        if (from + whole < size) {
            memcpy(w->half, text + from + whole, 4);
            w->halves = 1;
        }
    }
}

static void pbwtf__fill_word(pbwtf_writer *w)
{
    const uint32_t none = 0;
    if (w->halves > 0) {
        pbwtf__put(w, &none, 4);
    }
}

static void pbwtf__put_point(pbwtf_writer *w, const pbwt_point *p, const uint64_t *place)
{
    char record[48];
    const size_t dim = w->chunk.dim, bytes = dim * sizeof(double);
    size_t at = bytes;
    memcpy(record, p->x, bytes);
    if (w->chunk.flags & PBWTF_WEIGHTS) {
        memcpy(record + at, &p->weight, 8);
        at += 8;
    }
    memcpy(record + at, &p->id, 8);
    at += 8;
    if (place != NULL) {
        memcpy(record + at, place, 8);
        at += 8;
    }
    pbwtf__put(w, record, at);
}

PBWDEF void pbwtf_begin(pbwtf_writer *writer, FILE *file, const pbwt_tree *tree, uint32_t tile, uint32_t flags)
{
    size_t i;
    memset(writer, 0, sizeof *writer);
    writer->file = file;
    writer->start = pbwtf_tell(file);
    writer->failed = writer->start < 0;
    memcpy(writer->chunk.magic, "PBWTILE1", 8);
    writer->chunk.tile = tile;
    writer->chunk.flags = flags;
    pbwtf__write(writer, &writer->chunk, sizeof writer->chunk);
    if (tree != NULL) {
        writer->chunk.dim = (uint32_t)tree->dim;
        writer->chunk.own = tree->count;
        writer->chunk.duplicates = tree->duplicates;
        for (i = 0; i < tree->count; i++) {
            pbwtf__put_point(writer, tree->points + i, NULL);
        }
    }
}

PBWDEF pbw_status pbwtf_emit(void *user, const pbwt_tile *tile, size_t first, size_t count, const uint32_t *corners,
                             const uint32_t *links)
{
    pbwtf_writer *w = (pbwtf_writer *)user;
    const size_t each = (size_t)tile->dim + 1, all = w->chunk.flags & PBWTF_LINKS ? 2 * each : each;
    uint32_t block[64 * 8];
    size_t i, k, n = 0;
    (void)first;
    for (i = 0; i < count; i++) {
        memcpy(block + n, corners + i * each, each * 4);
        for (k = 0; k < each && all > each; k++) {
            const uint32_t link = links[i * each + k];
            block[n + each + k] = link == PBWT_OPEN ? 0x80000000u + (uint32_t)w->chunk.across++ : link;
            if (link < PBWT_OPEN && link >= 0x80000000u) {
                return PBW_ERROR_TOO_LARGE;
            }
        }
        n += all;
        if (n + 8 > 64 * 8 || i + 1 == count) {
            pbwtf__put(w, block, n * 4);
            n = 0;
        }
    }
    w->chunk.simplices += count;
    return w->failed ? PBW_ERROR_BACKEND : PBW_OK;
}

PBWDEF int pbwtf_end(pbwtf_writer *w, const pbwt_tile *tile, int dim)
{
    const uint64_t nothing = PBWT_NOTHING;
    size_t i;
    w->chunk.dim = (uint32_t)dim;
    pbwtf__fill_word(w);
    w->chunk.foreign = tile->foreign_count;
    for (i = 0; i < tile->foreign_count; i++) {
        const pbwt_vertex *v = tile->foreign + i;
        const uint64_t place = (uint64_t)v->part << 32 | v->index;
        pbwtf__put_point(w, &v->point, &place);
    }
    w->chunk.given = tile->leftover_count;
    pbwtf__put(w, tile->leftovers, tile->leftover_count * 4);
    pbwtf__fill_word(w);
    for (i = 0; i < w->chunk.across; i++) {
        pbwtf__write(w, &nothing, 8);
    }
    w->chunk.hull = tile->numbers.hull;
    w->chunk.hash = tile->hash;
    w->failed |= w->chunk.simplices != tile->numbers.simplices || fflush(w->file) != 0
              || !pbwtf_seek(w->file, (uint64_t)w->start);
    pbwtf__write(w, &w->chunk, sizeof w->chunk);
    w->failed |= fflush(w->file) != 0 || fseek(w->file, 0, SEEK_END) != 0;
    return !w->failed;
}

#endif /* PBW_TILEFILE_IMPLEMENTATION */
