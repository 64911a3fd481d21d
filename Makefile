# Makefile of pbw: `make help` lists the targets.  Needs GNU make, a C compiler and pthreads; CGAL, clang, valgrind
# and C++ are used where they are.  CC, CXX, CFLAGS, CXXFLAGS come from the environment or the command line; -j sets
# how many jobs run at once (as many as there are processors), B the folder for all that is built.
B = build
CFLAGS ?= -O2
CXXFLAGS ?= -O2
COUNT =
TIME = 60

WARN = -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Werror
C = $(CC) -std=c99 $(CFLAGS) $(WARN) -I. -Iexamples/lib
LIBS = -lpthread -lm
TESTS = $(patsubst tests/%.c,%,$(wildcard tests/test_*.c))
SLOWEST = test_threads test_scalar test_live_local      # started first, so that none runs alone in the end
ALONE = $(SLOWEST) test_digits test_order test_predicates       # have all of pbw.h that they need
HEAVY = test_cells test_improve test_mesh3 test_query test_sample test_wrap     # run long
COMPANIONS = $(patsubst examples/program/%.c,$B/objects/%.o,$(sort $(wildcard examples/program/library*.c)))
PROGRAM = $(COMPANIONS) $(filter-out $(COMPANIONS),$(patsubst examples/program/%.c,$B/objects/%.o,\
    $(wildcard examples/program/*.c)))                  # the companions take longest, so they come first
EXAMPLES = $(patsubst examples/%.c,%,$(filter-out examples/mpi.c,$(wildcard examples/*.c)))
MPI = $(if $(shell command -v mpicc),$B/mpi)
EXAMPLES_CXX = $(if $(shell command -v $(firstword $(CXX))),$(patsubst examples/%.cpp,%,$(wildcard examples/*.cpp)))
EXPECTED = $(patsubst examples/expected/%.txt,%,$(wildcard examples/expected/*.txt))
PRINTING = $(patsubst %,$B/%,$(filter $(EXAMPLES) $(EXAMPLES_CXX),$(EXPECTED)))        # what is expected
FUZZERS = $(patsubst tests/%.c,%,$(wildcard tests/fuzz_*.c))
HEADERS = pbw.h $(wildcard tests/*.h examples/*.h examples/lib/*.h examples/program/*.h)
SCRIPTS = $(filter packaging interface hashes examples asm oracle cells cmake csharp cuda fill gappa install page plane \
    python program programs queries seam tiles view web, $(patsubst tests/%.sh,%,$(wildcard tests/*.sh)))
# `make test` leaves these to `make test-all`, and tells the scripts by QUICK that one compiler is enough.
LONG = asm cells cmake csharp cuda gappa install oracle programs view web
SUITES = test test-all programs examples oracle asm arm names fuzz-long
export CC CXX

ifeq ($(MAKELEVEL),0)
# One make at a time in a folder: $B/.make is a link to the number of the process that works there.
ifneq ($(filter-out help clean,$(or $(MAKECMDGOALS),all)),)
OTHER := $(shell mkdir -p $B; ln -s $$PPID $B/.make 2> /dev/null || { \
    other=$$(readlink $B/.make); \
    if [ "$$other" != $$PPID ] && kill -0 "$$other" 2> /dev/null && ps -o comm= -p "$$other" | grep -q make; \
    then echo "$$other"; else ln -sfn $$PPID $B/.make; fi; })
$(if $(OTHER),$(error another make (process $(OTHER)) works in $B: wait for it, or use a folder of your own, make B=build2))
endif
MAKEFLAGS += -j$(shell getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
ifneq ($(word 2,$(filter $(SUITES),$(MAKECMDGOALS))),)
.NOTPARALLEL:                   # they share folders: one after the other, each with all jobs
endif
endif

.PHONY: all page demo web examples test test-all programs oracle arm asan ubsan tsan sanitize valgrind fuzz fuzz-long \
    asm names fuzz-plane fuzz-cells fuzz-fill fuzz-wrap campaign interface clean help FORCE
.DELETE_ON_ERROR:
.SECONDARY:

all: $B/pbw $(MPI) $(EXAMPLES:%=$B/%) $(EXAMPLES_CXX:%=$B/%) $B/libpbw_python.so

help:
	@echo 'make             builds the examples into $B/, the pbw program among them'
	@echo 'make demo        makes a model, samples, triangulates, proves, draws and writes it'
	@echo 'make GPU=1 B=build/gpu  builds them with pbw_cuda.cu: pbw cells --gpu, and in Python device="cuda"'
	@echo 'make web         WebAssembly for JavaScript and a page that shows it, by emscripten, into $B/web'
	@echo 'make page        puts examples/lib/view/ and film/ into pbw_view.h and pbw_film.h'
	@echo 'make examples    runs the examples and compares what they print with examples/expected'
	@echo 'make test        tests of every kind with one compiler; ends with `N passed, N failed, N skipped`'
	@echo 'make test-all    all tests: other compilers, libraries and programs where they are installed'
	@echo 'make bench       compares speed and memory with rivals that are installed (bench/bench.mk)'
	@echo 'make bench-cells Voronoi cells per second, beside voro++'
	@echo 'make bench-plane plane domains, beside CGAL'
	@echo 'make bench-domains  30 and 33 degrees on all plane domains of the tests'
	@echo 'make bench-models  pbw solid on all surfaces of the demo data of CGAL, beside Gmsh and TetGen'
	@echo 'make bench-wrap  wraps, beside CGAL; make bench-fill  constrained triangulations, beside TetGen'
	@echo 'make bench-wraps  wraps of all surfaces of the demo data of CGAL, checked exactly'
	@echo 'make bench-live  insert, remove and move, beside CGAL; make bench-live-goals  beside what is demanded'
	@echo 'make bench-scaling  queries, cells, live batches and solids on more and more threads'
	@echo 'make oracle      compares with CGAL            make names   names, warnings, copies, documentation'
	@echo 'make asm         looks for fused operations    make arm     64-bit Arm, in an emulator'
	@echo 'make install PREFIX=/usr/local DESTDIR=         and make uninstall: see examples/install/install.mk'
	@echo 'make clean       removes $B/'
	@echo 'make asan ubsan tsan valgrind                  the test programs under sanitizers;  sanitize: asan and ubsan'
	@echo 'make fuzz        fuzzers, TIME=60 each         make fuzz-long  ten million random small inputs'
	@echo 'make fuzz-plane  a million random small plane domains, the table in full, a million crossings'
	@echo 'make interface   records the public declarations of a version, once the history says what changed'
	@echo 'make campaign    damaged files, faults and limits under sanitizers; COUNT=1000 is how much'
	@echo 'make fuzz-cells  a million small inputs with cells in boxes, half-spaces, polygons, periodic boxes'
	@echo 'make fuzz-fill   10,000 shapes filled with tetrahedra: prisms, boxes, cells, bad input'
	@echo 'make fuzz-wrap   ten thousand random soups wrapped, each wrap checked exactly'
	@echo 'CC=clang CXX=clang++ CFLAGS=-O3 B=build/clang  for any of them;  COUNT=n random inputs in tests'

# Programs.  Each example is whole by itself, `cc -O2 -Iexamples/lib example.c -lpthread -lm`; here pbw.h and
# the headers that are compiled behind it are compiled once, and the macros that mark their implementations leave them
# out of these.  IMPLEMENTED does so for the companions, too.
SHARED = -DPBW__IMPLEMENTED -DPBWCK__IMPLEMENTED -DPBWQ__IMPLEMENTED -DPBWL__IMPLEMENTED
IMPLEMENTED := $(SHARED) $(shell cd examples/lib && sed -n 's/^\#define \(PBW[A-Z0-9]*__IMPLEMENTED\)$$/-D\1/p' \
    $$(sed -n 's/^\#include "\(pbw_.*\)"$$/\1/p' ../program/library*.c))
LIBRARY = pbw.h $(addprefix examples/lib/,pbw_check.h pbw_query.h pbw_live.h)
$B/libpbw.a: examples/install/library.c $(LIBRARY)
	@mkdir -p $B
	$C -fPIC -c $< -o $B/libpbw.o
	rm -f $@ && ar rcs $@ $B/libpbw.o

$(PROGRAM): $B/objects/%.o: examples/program/%.c $(HEADERS)
	@mkdir -p $(@D)
	$C $(SHARED) -fPIC -c $< -o $@

# The implementations of the companion headers: the tests, too, take from here those that they do not need in private.
$B/companions.a: $(COMPANIONS)
	rm -f $@ && ar rcs $@ $(COMPANIONS)

$B/pbw: $B/libpbw.a $(PROGRAM)
	$C $(PROGRAM) -o $@ $B/libpbw.a $(LIBS)

$(EXAMPLES:%=$B/%): $B/%: examples/%.c $(HEADERS) $B/libpbw.a $B/companions.a
	$C $(IMPLEMENTED) $< -o $@ $B/companions.a $B/libpbw.a $(LIBS)

# These use what only an implementation declares.
$(addprefix $B/,adapt fracture navmesh stuffing): IMPLEMENTED = $(SHARED)

$B/mpi: examples/mpi.c $(HEADERS) $B/libpbw.a $B/companions.a
	mpicc -std=c99 $(CFLAGS) $(WARN) $(IMPLEMENTED) -I. -Iexamples/lib $< -o $@ $B/companions.a $B/libpbw.a $(LIBS)

$(EXAMPLES_CXX:%=$B/%): $B/%: examples/%.cpp $(LIBRARY) $B/libpbw.a
	$(CXX) -std=c++11 $(CXXFLAGS) $(WARN) $(SHARED) -I. $< -o $@ $B/libpbw.a $(LIBS)

BINDING = $(wildcard examples/python/*.c)
$B/libpbw_python.so: $(BINDING) examples/python/pbw_python.h $(HEADERS) $B/libpbw.a $B/companions.a
	$C $(IMPLEMENTED) -fPIC -shared $(BINDING) -o $@ $B/companions.a $B/libpbw.a $(LIBS)

# Tests are compiled with -O1 for -O2, but for the slowest, and so are examples by `make test`; what they link has CFLAGS.
$(filter-out $(ALONE:%=$B/%),$(TESTS:%=$B/%)): $B/%: tests/%.c $(HEADERS) $B/libpbw.a $B/companions.a
	$C $< -o $@ $B/companions.a $B/libpbw.a $(LIBS)
$(ALONE:%=$B/%): $B/%: tests/%.c $(HEADERS)
	@mkdir -p $B
	$C $< -o $@ $(LIBS)
$(patsubst %,$B/%,$(filter-out $(SLOWEST),$(TESTS))): private CFLAGS := $(CFLAGS:-O2=-O1)
ifdef SANITIZED             # they take six times as long to compile as without, and what runs long is -O1
$(patsubst %,$B/%,$(filter-out $(SLOWEST) $(HEAVY),$(TESTS))) $(filter-out %library.o %_plane.o %_fill.o,$(PROGRAM)): \
    private override CFLAGS := $(CFLAGS:-O1=-O0)
endif
ifdef QUICK
$(EXAMPLES:%=$B/%): private CFLAGS := $(CFLAGS:-O2=-O1)
endif

$B/test_tilefile: examples/program/tiles.c examples/program/pbwt.c
$B/test_scalar: tests/test_threads.c
$B/test_digits: tests/test_predicates.c
$B/test_live_local: tests/test_live.c

$B/oracle_cgal: private CXXFLAGS := $(CXXFLAGS:-O2=-O1)
$B/oracle_cgal: tests/oracle_cgal.cpp $(HEADERS) $B/libpbw.a
	$(CXX) -std=c++17 -frounding-math $(CXXFLAGS) -Iexamples/lib -I. $< -o $@ $B/libpbw.a -lgmp -lmpfr $(LIBS)

# WebAssembly, as a package for `npm install ./build/web`, and index.html with all of it inside.  The stack lies first
# in memory, so that an overflow stops the program instead of changing data.
EMCC = emcc
WEB_MEMORY = 4GB
WEB_FLAGS = -sSTANDALONE_WASM --no-entry -sFILESYSTEM=0 -sEXPORTED_FUNCTIONS=_malloc,_free -sALLOW_MEMORY_GROWTH \
    -sINITIAL_MEMORY=1MB -sMAXIMUM_MEMORY=$(WEB_MEMORY) -sTOTAL_STACK=256KB -Wl,--stack-first
WEB = $(addprefix examples/web/,index.js index.d.ts package.json README.md)

web: $B/web/index.html

$B/web/pbw.wasm: examples/web/pbw_web.c pbw.h
	@mkdir -p $(@D)
	$(EMCC) -std=c99 -O3 $(WARN) -I. $(WEB_FLAGS) $< -o $@

$B/web/index.html: examples/web/page.html $(WEB) $B/web/pbw.wasm
	cp $(WEB) $(@D)
	{ printf 'export const wasm = "'; base64 $(@D)/pbw.wasm | tr -d '\n'; printf '";\n'; } > $(@D)/wasm.js
	sed -e '/^export default/d' -e '/^import .*wasm/d' -e 's/^export //' $(@D)/wasm.js $(@D)/index.js > $(@D)/inline.js
	{ sed 's/await WebAssembly.compile(/new WebAssembly.Module(/' $(@D)/inline.js; printf '%s\n' \
	    'module.exports = { __esModule: true, default: Delaunay, Delaunay, Voronoi, Delaunay3, PbwError };'; } \
	    > $(@D)/index.cjs
	cp $(@D)/index.d.ts $(@D)/index.d.cts
	sed -e '/^import .*index\.js/r $(@D)/inline.js' -e '/^import .*index\.js/d' $< > $@

$B/oracle_voro: tests/oracle_voro.cpp $(HEADERS) $B/libpbw.a
	$(CXX) -std=c++17 $(CXXFLAGS) -Iexamples/lib -I. $< -o $@ $B/libpbw.a -lvoro++ $(LIBS)

# Tests: each writes $B/NAME.log, which ends with its counts.  COUNT_NAME=n is for one, COUNT=n for all others.
OWN = $(or $(COUNT_$(<F)),$(COUNT))
HOW = $(if $(OWN),--count $(OWN),$(if $(QUICK),$(QUICK_$(<F)))) $(if $(UNDER),$(UNDER_$(<F))) \
    $(if $(SANITIZED),$(SANITIZED_$(<F))) $(if $(TSAN),$(TSAN_$(<F)))
$(TESTS:%=$B/%.log): $B/%.log: $B/% FORCE
	@sh tests/run.sh $@ $(UNDER) $< $(HOW)

$(SCRIPTS:%=$B/%.log) $B/arm.log: $B/%.log: tests/%.sh FORCE
	@mkdir -p $B
	+@sh tests/run.sh $@ sh $< $B

$B/test_io.log: $B/pbw
$B/view.log: $B/pbw $B/swarm $B/terrain
$B/examples.log: $(PRINTING)
$B/python.log: $B/libpbw_python.so $B/pbw
$B/csharp.log: $B/libpbw.so
$B/install.log: $B/pbw $B/libpbw.a $B/libpbw.so
$B/fill.log $B/plane.log $B/program.log $B/programs.log $B/queries.log $B/tiles.log: $B/pbw
$B/tiles.log: $(MPI)
$B/asm.log $B/hashes.log $B/oracle.log $B/cells.log $B/web.log $B/packaging.log: $B/libpbw.a
$B/asm.log $B/hashes.log $B/tiles.log: $B/companions.a

# One that does not compile is a failure, and the others still run.  The long ones come first, and they and examples are
# compiled before all: make would only come back to one whose program is not there when it has started all others.
FIRST = $(filter $(SLOWEST),$(TESTS))
REST = $(filter-out $(SLOWEST),$(TESTS))
test-all: LOGS = $(patsubst %,$B/%.log,$(FIRST) $(SCRIPTS) $(REST))
test: LOGS = $(patsubst %,$B/%.log,$(FIRST) $(filter-out $(LONG),$(SCRIPTS)) $(REST))
test-all test programs: BEFORE = $(strip $(if $(filter-out $(ALONE),$(TESTS)),$B/libpbw.a) $(FIRST:%=$B/%))
test-all test: BEFORE += $(if $(filter examples,$(SCRIPTS)),$B/pbw $(PRINTING))
test: export QUICK = 1
QUICK_test_answer = --count 6000
QUICK_test_predicates = --count 50000
QUICK_test_threads = --count 500
QUICK_test_scalar = --count 500
QUICK_test_tiles = --count 1000
QUICK_test_resources = --without 'threads, '
programs: LOGS = $(patsubst %,$B/%.log,$(FIRST) $(REST))
examples: LOGS = $B/examples.log
oracle: LOGS = $B/oracle.log
asm: LOGS = $B/asm.log
arm: LOGS = $B/arm.log
names: LOGS = $B/packaging.log
fuzz-long: LOGS = $(foreach seed,1 2 3 4 5 6 7 8,$B/fuzz.$(seed).log)
$(SUITES):
	@rm -f $(LOGS)
	@$(if $(BEFORE),$(MAKE) --no-print-directory -k $(BEFORE) || true)
	@$(MAKE) --no-print-directory -k $(LOGS) || true
	@sh tests/run.sh --total $(LOGS)

# The pages of pbw_view.h and pbw_film.h, from the files that web developers edit; tests/page.sh finds a header that is
# not up to date.
page:
	@mkdir -p $B
	for name in view film; do awk -v name=pbw$$name -f examples/lib/view/embed.awk examples/lib/$$name/page.html \
	    examples/lib/pbw_$$name.h > $B/page.h && { cmp -s $B/page.h examples/lib/pbw_$$name.h || \
	    cp $B/page.h examples/lib/pbw_$$name.h; } || exit 1; done

# The sums of the public declarations, see tests/interface.sh.
interface:
	@sh tests/interface.sh --update

demo: $B/pbw $B/model
	sh examples/demo.sh $B

asan ubsan tsan sanitize: %:
	@$(MAKE) --no-print-directory B=$B/$* CFLAGS='-O1 $(DEBUG) -fno-omit-frame-pointer -fsanitize=$(SANITIZE_$*)' \
	    SANITIZED=1 programs
DEBUG = -g1                     # reports with lines, for a fifth of the time of compilers; without, with functions
SANITIZE_asan = address
SANITIZE_ubsan = undefined -fno-sanitize-recover=all
SANITIZE_tsan = thread
SANITIZE_sanitize = address,undefined -fno-sanitize-recover=all -fno-sanitize=object-size   # which `address` sees, too
tsan: export TSAN = 1            # without tests whose tasks do not overlap
TSAN_test_threads = --without 'grows once: terrain'
TSAN_test_live_local = --without 'packed slots, 1 threads'
SANITIZED_test_resources = --without '1 threads' --without 'threads, '     # two of 12 builds of 200,000 points

# All but builds of 10,000 points and more, which take minutes there, and the test that reads a thread's dead stack.
valgrind:
	@$(MAKE) --no-print-directory B=$B/$@ CFLAGS='-O1 -g' COUNT=$(or $(COUNT),100) UNDER='$(VALGRIND)' programs
VALGRIND = valgrind -q --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite --error-exitcode=9
UNDER_test_answer = --without threads:
UNDER_test_resources = --without 'bytes a point' --without cancelled: --without 'on a stack'

fuzz: $(FUZZERS:%=$B/%.fuzz)
$(FUZZERS:%=$B/%.fuzz): $B/%.fuzz: tests/%.c $(HEADERS) FORCE
	@mkdir -p $B/corpus/$* tests/corpus
	@if clang -std=c99 -g -O1 -I. -Iexamples/lib -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all \
	    $< -o $B/$* $(LIBS) 2> $B/$*.log; then \
	    $B/$* -entropic=0 -max_total_time=$(TIME) -print_final_stats=1 $B/corpus/$* tests/corpus; \
	else $C -DFUZZ_MAIN $< -o $B/$* $(LIBS) && $B/$* --count 200000; fi

fuzz-solid: tests/fuzz_solid.c $(HEADERS) FORCE
	$(CC) -std=c99 -O1 -g -I. -Iexamples/lib -DFUZZ_MAIN -fsanitize=address,undefined -fno-sanitize-recover=all \
	    $< -o $B/fuzz_solid -lpthread -lm
	$B/fuzz_solid --count $(or $(COUNT),1000)

fuzz-plane: $B/test_mesh2 FORCE
	$B/test_mesh2 --count 1000000

fuzz-cells: $B/fuzz_cells_random FORCE
	$< --count 1000000

fuzz-fill: $B/test_fill_shapes FORCE
	$< --count $(or $(COUNT),10000)

fuzz-wrap: $B/test_wrap FORCE
	$< --count $(or $(COUNT),10000)

$B/fuzz.%.log: $B/fuzz_triangulate_random FORCE
	@sh tests/run.sh $@ $< --count 1250000 --seed $*
$(FUZZERS:%=$B/%_random): $B/%_random: tests/%.c $(HEADERS)
	@mkdir -p $B
	$C -DFUZZ_MAIN $< -o $@ $(LIBS)

# Mutations of every reader, faults and limits, under sanitizers, and then threads: COUNT (1000) is how much.
campaign:
	@$(MAKE) --no-print-directory B=$B/campaign CFLAGS='-O1 -g -fno-omit-frame-pointer -fsanitize=$(SANITIZE_sanitize)' \
	    $B/campaign/campaign.log
	@$(MAKE) --no-print-directory B=$B/campaign/tsan CFLAGS='-O1 -g -fno-omit-frame-pointer -fsanitize=thread' \
	    COUNT=600 $(CAMPAIGN_THREADS:%=$B/campaign/tsan/%.log)
CAMPAIGN_THREADS = test_threads test_levels test_contract test_live
$B/campaign.log: tests/campaign.sh $B/pbw $B/pbw_failing $B/campaign $(FUZZERS:%=$B/%_random) \
    $(addprefix $B/,test_levels test_contract test_adapt2 test_mesh2) FORCE
	sh $< $B $(COUNT)
$B/campaign: tests/campaign.c $(HEADERS)
	$C $< -o $@ $(LIBS)
$B/pbw_failing: tests/campaign_memory.c $B/libpbw.a $(PROGRAM)
	$C $(PROGRAM) $< -o $@ $B/libpbw.a $(foreach call,malloc calloc realloc,-Wl,--wrap=$(call)) $(LIBS)

clean:
	rm -rf $B

-include bench/bench.mk
-include tests/cuda.mk
-include examples/install/install.mk
