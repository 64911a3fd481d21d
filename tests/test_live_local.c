/* test_live_local.c: the tests of test_live.c, with a rebuild only where there is no other way, however slow; moves
   are verified all at once in every other commit, and made one by one in the rest.  Few changes are enough to be cut
   into tasks, and the threads wait at random. */
#if defined(__linux__) || defined(__APPLE__)
#define _GNU_SOURCE                                  /* sched_yield */
#endif
static void pause_a_while(void);
#define PBW__TEST_PAUSE() pause_a_while()
#define PBW__TEST_SMALL_SHARES
#define PBW_STATIC
#define PBW_IMPLEMENTATION
#define PBW_CHECK_IMPLEMENTATION
#define PBW_LIVE_IMPLEMENTATION
static double verify_at;
#define PBWL__REBUILD_AT(dim) (1e9)
#define PBWL__VERIFY_AT(dim) verify_at
#define CHOOSE_WAY(turn) (verify_at = ((turn) & 1) != 0 ? 0.0 : 1e9)
#define THREADS 3
#include "test_live.c"
#include <sched.h>

static void pause_a_while(void)
{
    static long calls;
    const long call = __atomic_fetch_add(&calls, 1, __ATOMIC_RELAXED);
    if (((uint64_t)call * UINT64_C(0x9e3779b97f4a7c15) >> 56 & 15) == 0) {
        sched_yield();
    }
}
