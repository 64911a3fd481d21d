/* meter.h: an allocator for options.resize that counts, checks its caller, and fails on demand.  Every change of size
   moves the block, new bytes are garbage, and freed ones too, so that stale pointers and unset memory show. */
#ifndef METER_H
#define METER_H

#include <pthread.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

typedef struct meter {
    pthread_mutex_t lock;
    long blocks, requests, faults;      /* live blocks; requests for memory so far; wrong sizes passed in */
    size_t bytes, peak;                 /* live bytes, most at one time */
    long fail_at;                       /* the request to refuse, from 1; 0 = none */
    int fail_all_after;                 /* refuse all later ones too */
    long refused;
} meter;

#define METER_HEAD 64                   /* keeps malloc's alignment */
#define METER_MARK 0x6d65746572u

static inline void meter_start(meter *m, long fail_at, int fail_all_after)
{
    memset(m, 0, sizeof *m);
    pthread_mutex_init(&m->lock, NULL);
    m->fail_at = fail_at;
    m->fail_all_after = fail_all_after;
}

static inline void *meter_resize(void *user, void *ptr, size_t old_size, size_t new_size)
{
    meter *m = (meter *)user;
    char *old = ptr != NULL ? (char *)ptr - METER_HEAD : NULL, *block = NULL;
    size_t head[2] = { 0, 0 };
    pthread_mutex_lock(&m->lock);
    if (old != NULL) {
        memcpy(head, old, sizeof head);
    }
    if (old == NULL ? old_size != 0 || new_size == 0 : head[0] != METER_MARK || head[1] != old_size) {
        m->faults++;
    }
    if (new_size != 0) {
        m->requests++;
        if (m->fail_at != 0 && (m->requests == m->fail_at || (m->fail_all_after && m->requests > m->fail_at))) {
            m->refused++;
            pthread_mutex_unlock(&m->lock);
            return NULL;
        }
        block = (char *)malloc(METER_HEAD + new_size);
        if (block == NULL) {
            pthread_mutex_unlock(&m->lock);
            return NULL;
        }
        memset(block + METER_HEAD, 0xa5, new_size);
        if (old != NULL) {
            memcpy(block + METER_HEAD, ptr, head[1] < new_size ? head[1] : new_size);
        }
        head[0] = METER_MARK;
        m->blocks++;
        m->bytes += new_size;
    }
    if (old != NULL) {
        m->blocks--;
        m->bytes -= head[1];
        memset(old, 0xdd, METER_HEAD + head[1]);
        free(old);
    }
    if (block != NULL) {
        head[1] = new_size;
        memcpy(block, head, sizeof head);
    }
    m->peak = m->bytes > m->peak ? m->bytes : m->peak;
    pthread_mutex_unlock(&m->lock);
    return block != NULL ? block + METER_HEAD : NULL;
}

#endif
