/* test_live_local.c: the tests of test_live.c, with a rebuild only where there is no other way, however slow; moves
   are verified all at once in every other commit, and in the rest made one by one. */
#define PBW_IMPLEMENTATION
static double verify_at;
#define PBW__REBUILD_AT(dim) (1e9)
#define PBW__VERIFY_AT(dim) verify_at
#define CHOOSE_WAY(turn) (verify_at = ((turn) & 1) != 0 ? 0.0 : 1e9)
#include "test_live.c"
