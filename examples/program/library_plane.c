/* library_plane.c: the implementation of the headers of plane domains. */
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#define PBW_ADAPT2_IMPLEMENTATION
#include "pbw_adapt2.h"
