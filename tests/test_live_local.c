/* test_live_local.c: the tests of test_live.c without rebuilds where there is another way, however slow. */
#define PBW_IMPLEMENTATION
#define PBW__REBUILD_AT(dim) (1e9)
#include "test_live.c"
