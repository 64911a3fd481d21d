/* library.c: the implementation of every header that the program uses. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#define PBW_IO_IMPLEMENTATION
#include "pbw_io.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#define PBW_MODEL_IMPLEMENTATION
#include "pbw_model.h"
#define PBW_PICTURE_IMPLEMENTATION
#include "pbw_picture.h"
#define PBW_SAMPLE_IMPLEMENTATION
#include "pbw_sample.h"
#define PBW_VIEW_IMPLEMENTATION
#include "pbw_view.h"
