/* fuzz_triangulate.c: small inputs decoded from bytes, triangulated, judged by the oracle and by pbw_check.
       make fuzz            libFuzzer where clang is installed, else random bytes
       clang -g -O1 -fsanitize=fuzzer,address,undefined tests/fuzz_triangulate.c -o fuzz -lm && ./fuzz
       cc -O2 -DFUZZ_MAIN tests/fuzz_triangulate.c -o fuzz -lm -lpthread && ./fuzz --count 1000000 --seed 1
       ./fuzz FILE ...      (FUZZ_MAIN too) runs these inputs */
#define PBW_IMPLEMENTATION
#include "../pbw.h"
#if defined(__clang__)                                 /* coverage of the library is to guide the fuzzer, not ours */
#pragma clang attribute push(__attribute__((no_sanitize("coverage"))), apply_to = function)
#endif
#include "meshes.h"
#include "small.h"
#include "test.h"
#if defined(__clang__)
#pragma clang attribute pop
#endif

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size)
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
    if (fault != NULL) {
        printf("%s\n", fault);
        small_print(&in);
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
    if (argc > 1 && argv[1][0] != '-') {
        for (i = 1; i < argc; i++) {
            FILE *file = fopen(argv[i], "rb");
            if (file != NULL) {
                LLVMFuzzerTestOneInput(bytes, fread(bytes, 1, sizeof bytes, file));
                fclose(file);
            }
        }
        return 0;
    }
    test_start(argc, argv, 100000);
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
