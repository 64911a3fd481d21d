/* test_syscalls.c: one thread with memory of the caller's makes no system call.  Each build runs in a child process
   under a filter of Linux (seccomp) that kills it at any call but write and exit_group.  Children that must be killed
   show that the filter sees what the library does. */
#if defined(__linux__)
#define _GNU_SOURCE
#endif
#include "../pbw.h"
#include "inputs.h"
#include "test.h"

#if defined(__linux__) && !defined(TEST_SANITIZED) && (defined(__x86_64__) || defined(__aarch64__))
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#ifdef __x86_64__
#define FILTER_ARCH AUDIT_ARCH_X86_64
#else
#define FILTER_ARCH AUDIT_ARCH_AARCH64
#endif

enum { LARGEST = 100000 };

/* Blocks one after the other; only the last one can grow in place or be given back. */
typedef struct arena {
    char *start;
    size_t size, used, last;
} arena;

static void *arena_resize(void *user, void *ptr, size_t old_size, size_t new_size)
{
    arena *a = (arena *)user;
    const size_t room = (new_size + 63) / 64 * 64;
    const int is_last = ptr != NULL && (char *)ptr == a->start + a->last;
    if (new_size == 0) {
        a->used = is_last ? a->last : a->used;
        return NULL;
    }
    if (is_last || (ptr != NULL && new_size <= old_size)) {
        if (is_last && a->size - a->last < room) {
            return NULL;
        }
        a->used = is_last ? a->last + room : a->used;
        return ptr;
    }
    if (a->size - a->used < room) {
        return NULL;
    }
    a->last = a->used;
    a->used += room;
    if (ptr != NULL) {
        memcpy(a->start + a->last, ptr, old_size);
    }
    return a->start + a->last;
}

typedef struct frame {
    int dim, weighted, threads, own_memory;
    size_t count;
    const double *points, *weights;
    arena memory;
} frame;

/* One frame of a game: a triangulation in memory that is there. */
static uint64_t make_frame(const frame *f)
{
    arena memory = f->memory;
    pbw_options options;
    pbw_mesh mesh;
    uint64_t hash = 0;
    memset(&options, 0, sizeof options);
    options.threads = f->threads;
    options.resize = f->own_memory ? arena_resize : NULL;
    options.resize_user = &memory;
    if (pbw_triangulate(f->dim, f->points, f->weighted ? f->weights : NULL, f->count, &options, &mesh) == PBW_OK) {
        hash = pbw_hash(&mesh, &options);
        pbw_free(&mesh);
    }
    return hash;
}

static int clock_calls;                               /* the clock of this machine needs system calls */

static int filter(void)
{
#define ALLOW(call) \
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1), BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)
    struct sock_filter strict[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, arch)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, FILTER_ARCH, 1, 0),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        ALLOW(SYS_write),
        ALLOW(SYS_exit_group),
        ALLOW(clock_calls ? SYS_gettimeofday : SYS_write),
        ALLOW(clock_calls ? SYS_clock_gettime : SYS_write),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
    };
    struct sock_fprog program;
    program.len = sizeof strict / sizeof strict[0];
    program.filter = strict;
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

enum { NOTHING, CLOCK, PROCESSORS, FRAMES };
enum { ENDED, KILLED, NO_FILTER };

/* Does `what` in a child under the filter; of frames, gets the hash of the second. */
static int in_child(int what, const frame *f, uint64_t *hash)
{
    int channel[2], state = 0;
    pid_t child;
    fflush(stdout);
    if (pipe(channel) != 0 || (child = fork()) < 0) {
        return NO_FILTER;
    }
    if (child == 0) {
        struct timeval now;
        uint64_t made = 0;
        (void)prctl(PR_SET_DUMPABLE, 0, 0, 0, 0);     /* no core files */
        if (!filter()) {
            _exit(2);
        }
        if (what == CLOCK) {
            gettimeofday(&now, NULL);
        } else if (what == PROCESSORS) {
            made = (uint64_t)sysconf(_SC_NPROCESSORS_ONLN);
        } else if (what == FRAMES) {
            (void)make_frame(f);
            made = make_frame(f);
        }
        _exit(write(channel[1], &made, sizeof made) == (ssize_t)sizeof made ? 0 : 1);
    }
    close(channel[1]);
    *hash = 0;
    if (read(channel[0], hash, sizeof *hash) != (ssize_t)sizeof *hash) {
        *hash = 0;
    }
    close(channel[0]);
    if (waitpid(child, &state, 0) != child) {
        return NO_FILTER;
    }
    return WIFEXITED(state) && WEXITSTATUS(state) == 0 ? ENDED
         : WIFSIGNALED(state) && WTERMSIG(state) == SIGSYS ? KILLED : NO_FILTER;
}

static void test_frames(frame *f)
{
    static const size_t sizes[] = { 4, 7, 30, 100, 1000, 10000, LARGEST };
    size_t i;
    uint64_t hash;
    for (i = 0; i < 4 * sizeof sizes / sizeof sizes[0]; i++) {
        f->dim = 2 + (int)(i & 1);
        f->weighted = (int)(i >> 1 & 1);
        f->count = sizes[i / 4];
        f->threads = f->count <= 1000 ? 0 : 1;        /* so few are for one thread: no need to count processors */
        if (test_begin("no system call: %dD, %zu points%s", f->dim, f->count, f->weighted ? ", weighted" : "")) {
            const uint64_t expected = make_frame(f);
            CHECK_EQUAL(in_child(FRAMES, f, &hash), ENDED);
            CHECK(expected != 0 && hash == expected);
            test_end();
        }
    }
}

/* What must be killed: the system's memory, threads, a question to the system. */
static void test_controls(frame *f)
{
    uint64_t hash;
    f->dim = 3;
    f->weighted = 0;
    f->threads = 1;
    f->count = LARGEST;
    if (test_begin("the filter kills: sysconf")) {
        CHECK_EQUAL(in_child(PROCESSORS, f, &hash), KILLED);
        test_end();
    }
    if (test_begin("the filter kills: memory of the system")) {
        f->own_memory = 0;
        CHECK_EQUAL(in_child(FRAMES, f, &hash), KILLED);
        f->own_memory = 1;
        test_end();
    }
    if (test_begin("the filter kills: two threads")) {
        f->threads = 2;
        CHECK_EQUAL(in_child(FRAMES, f, &hash), KILLED);
        f->threads = 1;
        test_end();
    }
}

int main(int argc, char **argv)
{
    frame f;
    uint64_t hash;
    double *points = (double *)malloc(LARGEST * 3 * sizeof(double));
    double *weights = (double *)malloc(LARGEST * sizeof(double));
    test_start(argc, argv, 0);
    memset(&f, 0, sizeof f);
    f.threads = f.own_memory = 1;
    f.memory.size = (size_t)160 << 20;
    f.memory.start = (char *)malloc(f.memory.size);
    if (points == NULL || weights == NULL || f.memory.start == NULL) {
        return 1;
    }
    input_fill(INPUT_UNIFORM, 3, LARGEST, test_seed, points);
    input_fill_weights(INPUT_WEIGHTS_HIDING, 3, LARGEST, test_seed, points, weights);
    f.points = points;
    f.weights = weights;
    clock_calls = in_child(CLOCK, NULL, &hash) == KILLED;
    if (clock_calls) {
        test_say("the clock of this machine needs system calls; they are let through");
    }
    if (in_child(NOTHING, NULL, &hash) == ENDED) {
        test_frames(&f);
        test_controls(&f);
    } else {
        (void)test_begin("no system call");
        test_skip("no filter of system calls works here");
    }
    free(points);
    free(weights);
    free(f.memory.start);
    return test_finish();
}
#else
int main(int argc, char **argv)
{
    test_start(argc, argv, 0);
    (void)test_begin("no system call");
    test_skip("the filters are those of Linux, and sanitizers make calls of their own");
    return test_finish();
}
#endif
