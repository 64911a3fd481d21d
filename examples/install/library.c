/* library.c: what libpbw.a and libpbw.so have: triangulations, their check, queries, live triangulations. */
#define PBW_IMPLEMENTATION
#define PBW_CHECK_IMPLEMENTATION
#define PBW_QUERY_IMPLEMENTATION
#define PBW_LIVE_IMPLEMENTATION
#include "pbw_check.h"
#include "pbw_query.h"
#include "pbw_live.h"
