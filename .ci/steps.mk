# The steps of .ci/run, each in a folder of its own.  They share the jobs of one make: where the last tests of a step
# leave processors idle, those of others run.  The longest step comes first.
ALL = gcc sanitize clang arm tsan
gcc = test-all CC=gcc CXX=g++
sanitize = sanitize CC=clang DEBUG= COUNT=1000 COUNT_test_clip=300 COUNT_test_tiles=300 COUNT_test_live=160 \
    COUNT_test_threads=300 COUNT_test_scalar=300
clang = test CC=clang CXX=clang++ WITHOUT='$(COMMON) $(OTHERWISE)'
arm = arm CC=gcc
tsan = tsan CC=gcc COMPANIONS= TESTS='test_threads test_live_local' COUNT_test_threads=300 COUNT_test_live_local=8
# Scripts for which the compiler makes no difference, or which take several compilers themselves, run with gcc only.
COMMON = cells gappa hashes interface packaging page plane program python queries tiles
# Tests of files, arguments and limits run with gcc and, compiled by clang, under sanitizers.
OTHERWISE = test_contract test_empty test_groups test_io test_read test_resources test_syscalls test_tilefile \
    test_view

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
