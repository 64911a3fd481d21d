/* test_digits.c: test_predicates.c with the digits of 26 bits that >>exact has where there is no __int128. */
#undef __SIZEOF_INT128__
#define CALLS 20000
#include "test_predicates.c"
