/* test.h: checks, counters and options of every test program; C99 and C++.

       int main(int argc, char **argv)
       {
           test_start(argc, argv, 1000);
           if (test_begin("sum of %d", 2)) {
               CHECK(1 + 1 == 2);
               CHECK_EQUAL(1 + 1, 2);
               test_end();
           }
           return test_finish();
       }

   A test is what lies between test_begin and test_end; it passes if all of its checks hold.  The last line of the
   output is `N passed, N failed, N skipped`, and the exit status is 1 if a test failed.  Checks are for one thread.
   Options, the first two as often as you like: --filter TEXT (only tests whose name has it), --without TEXT (not
   these), --part K/N (of these, each N-th from the K-th), --seed N, --count N (random cases), --verbose (a line for
   each test, with its seconds of processor time). */
#ifndef TEST_H
#define TEST_H

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#if defined(__GNUC__)
#define TEST_UNUSED __attribute__((unused))
#else
#define TEST_UNUSED
#endif

/* Whether a sanitizer of gcc or clang watches memory or threads. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TEST_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define TEST_SANITIZED 1
#endif
#endif

/* Whether that is the one of threads. */
#if defined(__SANITIZE_THREAD__)
#define TEST_WATCHES_THREADS 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define TEST_WATCHES_THREADS 1
#endif
#endif
#ifndef TEST_WATCHES_THREADS
#define TEST_WATCHES_THREADS 0
#endif

/* The size of a large input: a quarter under a sanitizer, which makes each point ten times as slow. */
#if defined(TEST_SANITIZED)
#define TEST_SIZE(n) ((n) / 4)
#else
#define TEST_SIZE(n) (n)
#endif

/* Tests of vector code are behind #ifdef PBW__SIMD: no processor with vectors may lose them by a name that changed. */
#if defined(PBW__IMPLEMENTED) && defined(__GNUC__) && (defined(__x86_64__) || defined(__AARCH64EL__))
#if !defined(PBW__SIMD) && !defined(PBW_NO_SIMD) && !defined(PBW__FMA)
#error "pbw.h has vectors for this processor, but not PBW__SIMD"
#endif
#endif

static uint64_t test_seed = 1;                  /* --seed */
static long test_count;                         /* --count, else what test_start was given */
static long test_part = 1, test_parts = 1;      /* --part */
static long test_named;                         /* tests that the names chose so far */
static int test_verbose, test_argc;
static char **test_argv;
static clock_t test_clock;                      /* when the test began */
static char test_name[160];
static long test_passed, test_failed, test_skipped, test_faults, test_checks;

#define CHECK(condition) test_check((condition) ? 1 : 0, __FILE__, __LINE__, #condition)
#define CHECK_EQUAL(a, b) test_check_equal((long long)(a), (long long)(b), __FILE__, __LINE__, #a " == " #b)

/* A line of detail, for tests that have something to report. */
TEST_UNUSED static void test_say(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    printf("    ");
    vprintf(format, arguments);
    printf("\n");
    va_end(arguments);
}

TEST_UNUSED static int test_check(int holds, const char *file, int line, const char *text)
{
    test_checks++;
    if (!holds && test_faults++ < 5) {
        printf("FAILED %s\n    %s:%d: %s\n", test_name, file, line, text);
    }
    return holds;
}

TEST_UNUSED static int test_check_equal(long long a, long long b, const char *file, int line, const char *text)
{
    int holds = test_check(a == b, file, line, text);
    if (!holds && test_faults <= 5) {
        test_say("%lld, %lld", a, b);
    }
    return holds;
}

/* Returns whether the test's name contains the text of one of these options; `otherwise` if none is given. */
TEST_UNUSED static int test_is_named(const char *option, int otherwise)
{
    int i;
    for (i = 1; i + 1 < test_argc; i++) {
        if (strcmp(test_argv[i], option) == 0) {
            otherwise = 0;
            if (strstr(test_name, test_argv[i + 1]) != NULL) {
                return 1;
            }
        }
    }
    return otherwise;
}

TEST_UNUSED static int test_begin(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(test_name, sizeof test_name, format, arguments);
    va_end(arguments);
    test_faults = test_checks = 0;
    test_clock = clock();
    return test_is_named("--filter", 1) && !test_is_named("--without", 0) && test_named++ % test_parts == test_part - 1;
}

TEST_UNUSED static void test_end(void)
{
    *(test_faults != 0 ? &test_failed : &test_passed) += 1;
    if (test_faults != 0 || test_verbose) {
        printf("%s %s: %ld checks, %ld faults, %.2f s\n", test_faults != 0 ? "FAILED" : "passed", test_name,
               test_checks, test_faults, (double)(clock() - test_clock) / CLOCKS_PER_SEC);
    }
    fflush(stdout);
}

/* In place of test_end, for a test that cannot run here. */
TEST_UNUSED static void test_skip(const char *why)
{
    test_skipped++;
    printf("skipped %s: %s\n", test_name, why);
}

TEST_UNUSED static void test_start(int argc, char **argv, long count)
{
    int i;
    test_count = count;
    test_argc = argc;
    test_argv = argv;
    for (i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--verbose") == 0) {
            test_verbose = 1;
        } else if ((strcmp(argv[i], "--filter") == 0 || strcmp(argv[i], "--without") == 0) && i + 1 < argc) {
            i++;
        } else if (strcmp(argv[i], "--seed") == 0 && i + 1 < argc) {
            test_seed = strtoull(argv[++i], NULL, 0);
        } else if (strcmp(argv[i], "--count") == 0 && i + 1 < argc) {
            test_count = atol(argv[++i]);
        } else if (strcmp(argv[i], "--part") == 0 && i + 1 < argc
                   && sscanf(argv[i + 1], "%ld/%ld", &test_part, &test_parts) == 2 && test_part > 0
                   && test_part <= test_parts) {
            i++;
        } else {
            fprintf(stderr, "usage: %s [--filter TEXT] [--without TEXT] [--part K/N] [--seed N] [--count N] [--verbose]\n",
                    argv[0]);
            exit(2);
        }
    }
}

TEST_UNUSED static int test_finish(void)
{
    printf("%ld passed, %ld failed, %ld skipped\n", test_passed, test_failed, test_skipped);
    return test_failed != 0;
}

#endif
