/* test_live_local.c: the tests of test_live.c, with a rebuild only where there is no other way, however slow. */
#define PBW_IMPLEMENTATION
#define PBW__REBUILD_AT(dim) (1e9)
#define PBW__VERIFY_AT(dim) (0.0)
#include "test_live.c"
