/* pbw.c: the implementation.  For queries: PBW_QUERY_IMPLEMENTATION and pbw_query.h, too; so for pbw_live.h,
   pbw_check.h. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
