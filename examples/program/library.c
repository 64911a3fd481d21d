/* library.c: the implementation of pbw.h and of the headers of cells, samples and tiles; library_*.c have others. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#define PBW_SAMPLE_IMPLEMENTATION
#include "pbw_sample.h"
#define PBW_TILES_IMPLEMENTATION
#include "pbw_tiles.h"
#define PBW_TILEFILE_IMPLEMENTATION
#include "pbw_tilefile.h"
