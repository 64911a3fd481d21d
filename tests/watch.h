/* watch.h: a callback for options.progress that checks how it is called, and cancels on demand.
       watch w;
       watch_start(&w, 0);
       options.progress = watch_progress;
       options.progress_user = &w; */
#ifndef WATCH_H
#define WATCH_H

#include <pthread.h>
#include <string.h>

typedef struct watch {
    pthread_t caller;
    long calls, cancel_at, wrong;       /* cancel_at: the call to cancel at, from 1; 0 = none */
    int stages;                         /* bits of the stages seen */
    pbw_stage stage;
    double done;
} watch;

static inline void watch_start(watch *w, long cancel_at)
{
    memset(w, 0, sizeof *w);
    w->caller = pthread_self();
    w->cancel_at = cancel_at;
}

static inline int watch_progress(void *user, pbw_stage stage, double done)
{
    watch *w = (watch *)user;
    int first = !(w->stages >> stage & 1);
    w->calls++;
    w->wrong += !pthread_equal(pthread_self(), w->caller);
    w->wrong += !(done >= 0 && done <= 1);
    if (first) {
        w->wrong += w->stages >> stage != 0 || done != 0;        /* in order, each from 0 ... */
        w->wrong += w->stages != 0 && w->done != 1;              /* ... to 1 */
    } else {
        w->wrong += stage != w->stage || done < w->done;
    }
    w->stages |= 1 << stage;
    w->stage = stage;
    w->done = done;
    return w->calls == w->cancel_at;
}

#endif
