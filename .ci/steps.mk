# The steps of .ci/run, each in a folder of its own.  They share the jobs of one make: where the last tests of a step
# leave processors idle, those of others run.  The longest step comes first.
ALL = gcc sanitize clang arm tsan
gcc = test-all CC=gcc CXX=g++
sanitize = sanitize CC=clang COUNT=2000 COUNT_test_threads=600 COUNT_test_scalar=600
clang = test CC=clang CXX=clang++ WITHOUT='gappa hashes page python'
arm = arm CC=gcc
tsan = tsan CC=gcc TESTS='test_threads test_live_local' COUNT_test_threads=600 COUNT_test_live_local=16

.PHONY: all logs $(ALL)
all: $(ALL)
logs: ; @echo $(ALL:%=build/ci-%.log)

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
