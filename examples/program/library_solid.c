/* library_solid.c: the implementation of the headers of surfaces and solids. */
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_WRAP_IMPLEMENTATION
#include "pbw_wrap.h"
#define PBW_MESH3_IMPLEMENTATION
#include "pbw_mesh3.h"
#define PBW_ADAPT3_IMPLEMENTATION
#include "pbw_adapt3.h"
