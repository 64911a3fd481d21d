/* fuzz.h: what the fuzzers of small inputs share.  Include pbw.h before; then define

       static const char *fuzz(const unsigned char *data, size_t size, int print)

   which decodes an input from the bytes, prints it if `print` is set, and returns NULL, or what is wrong with the
   answers.  libFuzzer needs no more; with FUZZ_MAIN the program has a main, which tries random bytes, or the files it
   is given. */
#ifndef FUZZ_H
#define FUZZ_H

#include "inputs.h"
#include "test.h"

static const char *fuzz(const unsigned char *data, size_t size, int print);

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size)
{
    const char *fault = fuzz(data, size, 0);
    if (fault != NULL) {
        printf("%s\n", fault);
        fuzz(data, size, 1);
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
#endif
