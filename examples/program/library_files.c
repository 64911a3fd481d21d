/* library_files.c: the implementation of the headers of files, models, pictures and pages. */
#define PBW_IO_IMPLEMENTATION
#include "pbw_io.h"
#define PBW_MODEL_IMPLEMENTATION
#include "pbw_model.h"
#define PBW_PICTURE_IMPLEMENTATION
#include "pbw_picture.h"
#define PBW_VIEW_IMPLEMENTATION
#include "pbw_view.h"
