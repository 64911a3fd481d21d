# The steps of .ci/run, each in a folder of its own.  They share the jobs of one make: where the last tests of a step
# leave processors idle, those of others run.  The longest step comes first.
ALL = gcc sanitize clang arm tsan
gcc = test-all CC=gcc CXX=g++ COUNT_test_answer=6000 COUNT_test_predicates=50000 COUNT_test_scalar=500 \
    COUNT_test_threads=500 COUNT_test_tiles=1000
sanitize = sanitize CC=clang DEBUG= COUNT=300 COUNT_test_clip=150 COUNT_test_fill=20 COUNT_test_live=80 \
    COUNT_test_live_local=40 COUNT_test_scalar=150 COUNT_test_threads=150 COUNT_test_wrap=20
clang = test CC=clang CXX=clang++ SCRIPTS=examples TESTS='test_answer test_digits test_live test_live_local \
    test_predicates test_query test_threads'
arm = arm CC=gcc
tsan = tsan CC=gcc TESTS='test_threads test_live_local' COUNT_test_threads=150 COUNT_test_live_local=4
# Scripts test a program or take several compilers themselves, so they run with gcc only.  With clang at full speed run
# the tests of signs, threads, live triangulations and queries; all others run with gcc and, compiled by clang, under
# sanitizers.  That clang at its highest level makes of companion headers what gcc makes, hashes.sh compares.

.PHONY: all logs packages $(ALL)
all: $(ALL)
logs: ; @echo $(ALL:%=build/ci-%.log)

# Packages that sanitizers do not need are installed, by the command PACKAGES, while these run.
gcc clang arm: | packages
packages:
	@mkdir -p build
	@$(or $(PACKAGES),true) > build/ci-packages.log 2>&1 || \
	    echo "packages are missing, so tests are skipped or fail: see build/ci-packages.log"

# What a step says goes to its log.  When it has ended, that is printed at once, without compilers' commands and
# without make's words on failures, which would hide the count.
$(ALL):
	@mkdir -p build/$@
	@date +%s > build/$@/start
	+@$(MAKE) --no-print-directory $($@) B=build/$@ > build/ci-$@.log 2>&1 || true
	@sed -i '/^make.*\*\*\*/d' build/ci-$@.log
	@{ echo "=== $@: make $($@)"; grep -v '^[a-z+]* -std=' build/ci-$@.log | tail -n 100; \
	    echo "=== $@: $$(($$(date +%s) - $$(cat build/$@/start))) seconds"; } > build/$@/said
	@cat build/$@/said
