/* fuzz_triangulate.c: small inputs decoded from bytes, triangulated, judged by the oracle and by pbw_check.
       make fuzz            libFuzzer where clang is installed, else random bytes
       clang -g -O1 -fsanitize=fuzzer,address,undefined tests/fuzz_triangulate.c -o fuzz -lm && ./fuzz
       cc -O2 -DFUZZ_MAIN tests/fuzz_triangulate.c -o fuzz -lm -lpthread && ./fuzz --count 1000000 --seed 1
       ./fuzz FILE ...      (FUZZ_MAIN too) runs these inputs */
#define PBW_IMPLEMENTATION
#define PBW_CHECK_IMPLEMENTATION
#include "pbw_check.h"
#if defined(__clang__)                                 /* coverage of the library is to guide the fuzzer, not ours */
#pragma clang attribute push(__attribute__((no_sanitize("coverage"))), apply_to = function)
#endif
#include "meshes.h"
#include "small.h"
#include "fuzz.h"
#if defined(__clang__)
#pragma clang attribute pop
#endif

static const char *fuzz(const unsigned char *data, size_t size, int print)
{
    small_input in;
    pbw_options options;
    const char *fault;
    memset(&options, 0, sizeof options);
    options.threads = 1;
    small_decode(&in, data, size);
    fault = small_test(&in, &options, 1);
    if (fault == NULL && size % 4 == 0) {             /* reversed, the answer is the same */
        pbw_mesh one, other;
        small_input turned = in;
        int i;
        for (i = 0; i < in.count; i++) {
            int from = in.count - 1 - i;
            memcpy(turned.points + i * in.dim, in.points + from * in.dim, (size_t)in.dim * sizeof *in.points);
            turned.weights[i] = in.weights[from];
        }
        pbw_triangulate(in.dim, in.points, small_weights(&in), (size_t)in.count, &options, &one);
        options.flags = PBW_ANY_ORDER;
        pbw_triangulate(in.dim, turned.points, small_weights(&turned), (size_t)in.count, &options, &other);
        fault = pbw_hash(&one, NULL) == pbw_hash(&other, NULL) ? NULL : "another answer for another order";
        pbw_free(&one);
        pbw_free(&other);
    }
    if (print) {
        small_print(&in);
    }
    return fault;
}
