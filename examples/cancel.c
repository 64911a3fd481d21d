/* cancel.c: a build that reports its progress and is stopped half-way, then the same build to its end.
   cc -O2 -I. examples/cancel.c -o cancel -lpthread -lm
   Prints the statuses and counts of expected/cancel.txt, the progress itself on the error stream. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>
#include <stdlib.h>

typedef struct watch {
    double stop_at;                    /* of the build stage; above 1: never */
    int calls;
} watch;

static int on_progress(void *user, pbw_stage stage, double done)
{
    static const char *const names[] = { "order", "build", "output", "check" };
    watch *w = (watch *)user;
    w->calls++;
    fprintf(stderr, "\r%s %3.0f %% ", names[stage], 100 * done);
    return stage == PBW_STAGE_BUILD && done >= w->stop_at;           /* nonzero: stop */
}

int main(void)
{
    enum { COUNT = 200000 };
    double *points = (double *)malloc(3 * COUNT * sizeof *points);
    unsigned long long state = 1;
    pbw_options options = { 0 };
    pbw_mesh mesh = { 0 };
    watch w = { 0.5, 0 };
    for (int i = 0; points != NULL && i < 3 * COUNT; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = (double)(state >> 11) / 9007199254740992.0;
    }
    if (points == NULL) {
        return 1;
    }
    options.progress = on_progress;
    options.progress_user = &w;
    for (w.stop_at = 0.5; w.stop_at < 3; w.stop_at *= 4) {
        pbw_status status = pbw_triangulate(3, points, NULL, COUNT, &options, &mesh);
        fprintf(stderr, "\n");
        printf("%s: %zu tetrahedra, asked %s\n", pbw_status_string(status), mesh.simplex_count,
               w.calls > 0 ? "at least once" : "never");
    }
    pbw_free(&mesh);                   /* fine after a failure too */
    free(points);
    return 0;
}
