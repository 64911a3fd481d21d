#define PBW_IMPLEMENTATION
#include "pbw.h"
