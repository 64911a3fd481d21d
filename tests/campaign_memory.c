/* campaign_memory.c: malloc, calloc and realloc of a program linked with -Wl,--wrap for each: the request number
   FAIL_AT of the environment fails; at the end, the number of requests is written to the file that COUNT_TO names. */
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *ptr, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *ptr, size_t size);

static long requests, fail_at = -1;

static void write_count(void)
{
    FILE *file = fopen(getenv("COUNT_TO"), "w");
    if (file != NULL) {
        fprintf(file, "%ld\n", requests);
        fclose(file);
    }
}

static int fails(void)
{
    if (fail_at < 0) {
        const char *text = getenv("FAIL_AT");
        fail_at = text != NULL ? atol(text) : 0;
        if (getenv("COUNT_TO") != NULL) {
            atexit(write_count);
        }
    }
    return __atomic_add_fetch(&requests, 1, __ATOMIC_RELAXED) == fail_at;
}

void *__wrap_malloc(size_t size)
{
    return fails() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return fails() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *ptr, size_t size)
{
    return size != 0 && fails() ? NULL : __real_realloc(ptr, size);
}
