/* test_scalar.c: test_threads.c without vectors, and with links of 64 bits. */
#define PBW_NO_SIMD
#define PBW_WIDE
#define COUNT 1500
#include "test_threads.c"
