/* library_fill.c: the implementation of the header that fills surfaces. */
#define PBW_FILL_IMPLEMENTATION
#include "pbw_fill.h"
