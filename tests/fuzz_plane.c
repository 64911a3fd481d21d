/* fuzz_plane.c: small plane domains decoded from bytes, judged by an exact check and by a slow way (planes.h).
       make fuzz            libFuzzer where clang is installed, else random bytes
       cc -O2 -DFUZZ_MAIN tests/fuzz_plane.c -o fuzz -lm -lpthread && ./fuzz --count 100000 --seed 1 */
#define PBW_IMPLEMENTATION
#include "../pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "../examples/lib/pbw_mesh2.h"
#if defined(__clang__)                                 /* coverage of the library is to guide the fuzzer, not ours */
#pragma clang attribute push(__attribute__((no_sanitize("coverage"))), apply_to = function)
#endif
#include "inputs.h"
#include "planes.h"
#include "fuzz.h"
#if defined(__clang__)
#pragma clang attribute pop
#endif

static const char *fuzz(const unsigned char *data, size_t size, int print)
{
    planes_small s;
    const char *fault;
    planes_small_decode(&s, data, size);
    fault = planes_small_judge(&s);
    if (print) {
        planes_small_decode(&s, data, size);
        planes_small_print(&s);
    }
    return fault;
}
