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
#include "test.h"
#if defined(__clang__)
#pragma clang attribute pop
#endif

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size)
{
    planes_small s;
    const char *fault;
    planes_small_decode(&s, data, size);
    fault = planes_small_judge(&s);
    if (fault != NULL) {
        printf("%s\n", fault);
        planes_small_decode(&s, data, size);
        planes_small_print(&s);
        fflush(stdout);
        abort();
    }
    return 0;
}

#ifdef FUZZ_MAIN
int main(int argc, char **argv)
{
    unsigned char bytes[512];
    int i;
    test_start(argc, argv, 20000);
    if (test_begin("fuzz: %ld random inputs, seed %llu", test_count, (unsigned long long)test_seed)) {
        uint64_t state = test_seed * 0x9e3779b97f4a7c15u;
        long n;
        for (n = 0; n < test_count; n++) {
            for (i = 0; i < (int)sizeof bytes; i += 8) {
                uint64_t x = input_next(&state);
                memcpy(bytes + i, &x, 8);
            }
            CHECK(LLVMFuzzerTestOneInput(bytes, 64 + input_below(&state, 449)) == 0);
        }
        test_end();
    }
    return test_finish();
}
#endif
