# The steps of .ci/run, each in a folder of its own.  They share the jobs of one make: where the last tests of a step
# leave processors idle, those of others run.  The longest step comes first.
ALL = gcc sanitize clang arm tsan
gcc = test-all CC=gcc CXX=g++ COUNT_test_answer=6000 COUNT_test_predicates=50000 COUNT_test_scalar=500 \
    COUNT_test_threads=500 COUNT_test_tiles=1000
sanitize = sanitize CC=clang DEBUG= COUNT=300 COUNT_test_clip=150 COUNT_test_fill=20 COUNT_test_live=80 \
    COUNT_test_live_local=40 COUNT_test_scalar=150 COUNT_test_threads=150 COUNT_test_wrap=20
clang = test CC=clang CXX=clang++ WITHOUT='$(COMMON) $(OTHERWISE)'
arm = arm CC=gcc
tsan = tsan CC=gcc COMPANIONS= TESTS='test_threads test_live_local' COUNT_test_threads=150 COUNT_test_live_local=4
# Scripts for which the compiler makes no difference, or which take several compilers themselves, run with gcc only.
COMMON = hashes interface packaging page plane program python queries seam tiles
# With clang the tests of signs, threads, live triangulations and queries run at full speed.  Those of files, arguments,
# limits and companion headers run with gcc and, compiled by clang, under sanitizers; that clang at its highest level
# makes what gcc makes of companion headers, hashes compares.
OTHERWISE = $(addprefix test_,adapt2 api cells check clip contract crossings empty fill groups improve interpolate io \
    levels live_query mesh2 mesh3 order read resources sample scalar syscalls tilefile tiles tools view wrap)

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
