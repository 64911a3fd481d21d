/* allocator.c: all memory through one function of ours, which counts and can refuse.
   cc -O2 -I. examples/allocator.c -o allocator -lpthread -lm
   Prints that our count agrees with the library's and that all is given back: expected/allocator.txt. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>
#include <stdlib.h>

typedef struct pool { size_t used, peak, most; } pool;

/* ptr NULL: allocate; new_size 0: free; else resize.  The library says how large the old block was. */
static void *resize(void *user, void *ptr, size_t old_size, size_t new_size)
{
    pool *p = (pool *)user;
    void *block = NULL;
    if (new_size == 0) {
        free(ptr);
    } else if (p->used - old_size + new_size > p->most || (block = realloc(ptr, new_size)) == NULL) {
        return NULL;                   /* refused: the old block stays */
    }
    p->used = p->used - old_size + new_size;
    p->peak = p->used > p->peak ? p->used : p->peak;
    return block;
}

int main(void)
{
    enum { COUNT = 20000 };
    static double points[3 * COUNT];
    unsigned long long state = 1;
    pbw_options options = { 0 };
    pbw_mesh mesh = { 0 };
    pool p = { 0, 0, (size_t)-1 };
    pbw_status status;
    for (int i = 0; i < 3 * COUNT; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = (double)(state >> 11) / 9007199254740992.0;
    }
    options.threads = 1;               /* then resize need not be thread-safe */
    options.resize = resize;
    options.resize_user = &p;
    status = pbw_triangulate(3, points, NULL, COUNT, &options, &mesh);
    printf("%s: peak %s statistics.peak_bytes\n", pbw_status_string(status),
           p.peak == mesh.statistics.peak_bytes ? "equals" : "differs from");
    pbw_free(&mesh);
    printf("after pbw_free: %zu bytes held\n", p.used);
    p.most = 1000000;
    status = pbw_triangulate(3, points, NULL, COUNT, &options, &mesh);
    printf("with at most 1 MB: %s, %zu bytes held\n", pbw_status_string(status), p.used);
    return 0;
}
