/* library.c: pbw.h, checks, queries, live points, cells, samples and tiles are here, others in library_*.c. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_CHECK_IMPLEMENTATION
#include "pbw_check.h"
#define PBW_QUERY_IMPLEMENTATION
#include "pbw_query.h"
#define PBW_LIVE_IMPLEMENTATION
#include "pbw_live.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#define PBW_SAMPLE_IMPLEMENTATION
#include "pbw_sample.h"
#define PBW_TILES_IMPLEMENTATION
#include "pbw_tiles.h"
#define PBW_TILEFILE_IMPLEMENTATION
#include "pbw_tilefile.h"
