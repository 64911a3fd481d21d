/* jobs.c: the library's work done by a job system of ours: a pool of POSIX threads that several builds may share.
   cc -O2 -I. examples/jobs.c -o jobs -lpthread -lm
   Prints that the answer is the one of a single thread (expected/jobs.txt); how many jobs there were on the error
   stream, which may be none: the library cuts its work in pieces only where that pays. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WORKERS = 3, COUNT = 200000 };

typedef struct batch {                 /* one call of run; lies on its caller's stack */
    void (*task)(void *arg, int i);
    void *arg;
    int next, tasks, left;             /* the task to start next, how many there are, how many have not returned */
    struct batch *below;
} batch;

typedef struct pool {
    pthread_mutex_t lock;              /* guards all that follows */
    pthread_cond_t changed;            /* new work, or a batch is done, or stop */
    batch *top;                        /* batches with tasks to start */
    int stop, finished;
} pool;

/* Takes a task off the batch, runs it without the lock, counts it.  The lock is held before and after. */
static void work_on(pool *p, batch *b)
{
    int i = b->next++;
    if (b->next == b->tasks) {
        batch **link = &p->top;
        while (*link != b) {
            link = &(*link)->below;
        }
        *link = b->below;
    }
    pthread_mutex_unlock(&p->lock);
    b->task(b->arg, i);
    pthread_mutex_lock(&p->lock);
    p->finished++;
    if (--b->left == 0) {
        pthread_cond_broadcast(&p->changed);
    }
}

static void *worker(void *user)
{
    pool *p = (pool *)user;
    pthread_mutex_lock(&p->lock);
    while (!p->stop) {
        if (p->top != NULL) {
            work_on(p, p->top);
        } else {
            pthread_cond_wait(&p->changed, &p->lock);
        }
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

/* What pbw_options.run must do: task(arg, i) once for each i, on any thread, back when all have returned. */
static void run(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    pool *p = (pool *)user;
    batch b = { task, arg, 0, tasks, tasks, NULL };
    if (tasks <= 0) {
        return;
    }
    pthread_mutex_lock(&p->lock);
    b.below = p->top;
    p->top = &b;
    pthread_cond_broadcast(&p->changed);
    while (b.next < b.tasks) {
        work_on(p, &b);                /* the caller helps; alone it would do, only later */
    }
    while (b.left > 0) {
        pthread_cond_wait(&p->changed, &p->lock);
    }
    pthread_mutex_unlock(&p->lock);
}

int main(void)
{
    pool p = { PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, NULL, 0, 0 };
    pthread_t threads[WORKERS];
    int started = 0;
    double *points = (double *)malloc(3 * COUNT * sizeof *points);
    unsigned long long state = 1;
    pbw_options options = { 0 };
    pbw_mesh ours = { 0 }, serial = { 0 };
    pbw_status status = PBW_ERROR_MEMORY, status_serial = PBW_ERROR_MEMORY;
    for (int i = 0; points != NULL && i < 3 * COUNT; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = (double)(state >> 11) / 9007199254740992.0;
    }
    while (started < WORKERS && pthread_create(&threads[started], NULL, worker, &p) == 0) {
        started++;
    }
    if (points != NULL) {
        options.threads = started + 1;
        options.run = run;
        options.run_user = &p;
        status = pbw_triangulate(3, points, NULL, COUNT, &options, &ours);
        options.threads = 1;
        options.run = NULL;
        status_serial = pbw_triangulate(3, points, NULL, COUNT, &options, &serial);
    }
    pthread_mutex_lock(&p.lock);
    p.stop = 1;
    pthread_cond_broadcast(&p.changed);
    pthread_mutex_unlock(&p.lock);
    while (started > 0) {
        pthread_join(threads[--started], NULL);
    }
    fprintf(stderr, "%d jobs\n", p.finished);
    printf("our jobs:   %s, %zu tetrahedra\n", pbw_status_string(status), ours.simplex_count);
    printf("one thread: %s, %zu tetrahedra\n", pbw_status_string(status_serial), serial.simplex_count);
    printf("the arrays are %s\n", ours.simplex_count == serial.simplex_count && serial.simplex_count > 0 &&
           memcmp(ours.simplices, serial.simplices, 4 * sizeof(pbw_index) * serial.simplex_count) == 0 &&
           memcmp(ours.neighbors, serial.neighbors, 4 * sizeof(pbw_index) * serial.simplex_count) == 0 ? "equal" :
           "different");
    pbw_free(&ours);
    pbw_free(&serial);
    free(points);
    return 0;
}
