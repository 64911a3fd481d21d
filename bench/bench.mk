# bench.mk: make bench, included by the Makefile.
#   make bench                        a few minutes, up to 1e6 points
#   make bench PHASES=1 CSV=rows.csv  adds phases, by clocks in the build, and counters; also writes the rows there
#   make bench SWEEP=1                1, 2, 4, ... threads, all kinds of points
#   make bench ARGS=--quick           a minute;  bench/bench.c has the method, build/bench --help the options
#   make bench BENCH_FLAGS="-O3 -march=native"
# Rivals are linked where a program that uses them compiles and links; the probes run only if bench is asked for.
BENCH_FLAGS ?= -O3
BENCH_WARN = -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow
BENCH_C = $(CC) -std=c99 $(BENCH_FLAGS) $(BENCH_WARN)
BENCH_CXX = $(CXX) -std=c++17 $(BENCH_FLAGS) $(BENCH_WARN) -DNDEBUG
BENCH_INPUTS = pbw.h bench/bench.h bench/bench.mk tests/inputs.h

ifneq ($(filter bench build/bench build/bench_clocks,$(MAKECMDGOALS)),)
# $(call bench_has,includes,libraries): yes or nothing
bench_has = $(shell printf '$(foreach h,$(1),\043include <$(h)>\n)int main() { return 0; }\n' | \
    $(CXX) -std=c++17 -x c++ -DTETLIBRARY - -o /dev/null $(2) 2>/dev/null && echo yes)

ifeq ($(call bench_has,CGAL/Exact_predicates_inexact_constructions_kernel.h,-lgmp -lmpfr),yes)
BENCH_OBJECTS += build/rival_cgal.o
BENCH_USES += -DBENCH_CGAL
BENCH_LIBS += -lgmp -lmpfr
ifeq ($(call bench_has,tbb/global_control.h tbb/scalable_allocator.h,-ltbb -ltbbmalloc),yes)
BENCH_USES += -DBENCH_TBB
BENCH_LIBS += -ltbb -ltbbmalloc
build/rival_cgal.o: BENCH_CXX += -DCGAL_LINKED_WITH_TBB
endif
endif
ifeq ($(call bench_has,tetgen.h,-ltet),yes)
BENCH_OBJECTS += build/rival_tetgen.o
BENCH_USES += -DBENCH_TETGEN
BENCH_LIBS += -ltet
endif
ifeq ($(call bench_has,libqhull_r/libqhull_r.h,-lqhull_r),yes)
BENCH_OBJECTS += build/rival_qhull.o
BENCH_USES += -DBENCH_QHULL
BENCH_LIBS += -lqhull_r
endif
endif

# C++ links if there is a rival in it; without one a C compiler is all that is needed.
build/bench build/bench_clocks: %: %.o $(BENCH_OBJECTS)
	$(if $(BENCH_OBJECTS),$(CXX),$(CC)) $(BENCH_FLAGS) $^ -o $@ $(BENCH_LIBS) -lpthread -lm

build/bench_clocks.o: BENCH_USES += -DBENCH_CLOCKS
build/bench.o build/bench_clocks.o: bench/bench.c examples/lib/pbw_check.h $(BENCH_INPUTS)
	@mkdir -p build
	$(BENCH_C) $(BENCH_USES) -I. -Iexamples/lib -DBENCH_FLAGS='"$(BENCH_FLAGS)"' -c $< -o $@

build/rival_%.o: bench/rival_%.cpp bench/bench.h bench/bench.mk
	@mkdir -p build
	$(BENCH_CXX) -c $< -o $@

build/rival_%.o: bench/rival_%.c bench/bench.h bench/bench.mk
	@mkdir -p build
	$(BENCH_C) -c $< -o $@

.PHONY: bench
bench: build/bench$(PHASES:%=_clocks)
	$< $(SWEEP:%=--sweep) $(PHASES:%=--phases) $(CSV:%=--csv %) $(ARGS)

# Cells: the library beside voro++, if it is installed.
BENCH_VORO = $(shell printf '\043include <voro++/voro++.hh>\nint main() { voro::voronoicell c; return 0; }\n' | \
    $(CXX) -x c++ - -o /dev/null -lvoro++ 2>/dev/null && echo yes)
build/bench_cells: bench/cells.cpp examples/lib/pbw_cells.h $(BENCH_INPUTS)
	@mkdir -p build
	$(CXX) -std=c++17 $(BENCH_FLAGS) $(if $(BENCH_VORO),-DBENCH_VORO) -I. -Iexamples/lib $< -o $@ \
	    $(if $(BENCH_VORO),-lvoro++) -lpthread -lm
.PHONY: bench-cells
bench-cells: build/bench_cells
	$<

# Queries beside CGAL and nanoflann: bench/query.cpp
build/bench_query: bench/query.cpp examples/lib/pbw_query.h $(BENCH_INPUTS)
	@mkdir -p build
	$(CXX) -std=c++17 -frounding-math $(BENCH_FLAGS) -DNDEBUG -I. -Iexamples/lib $< -o $@ -lgmp -lmpfr -lpthread -lm

.PHONY: bench-query
bench-query: build/bench_query
	$< $(POINTS)

# Every number that is demanded of queries and cells, with its goal.
.PHONY: bench-query-goals
bench-query-goals: build/bench_query build/bench_cells
	{ build/bench_query $(or $(POINTS),100000); build/bench_cells $(or $(POINTS),100000) 3; } | \
	    grep -E 'D, |goal|D .* us '

# Plane domains, beside CGAL where it is installed; ARGS=q for a tenth of the size.
ifneq ($(filter bench-plane build/bench_plane,$(MAKECMDGOALS)),)
PLANE_HAS := $(shell printf '\043include <CGAL/Constrained_Delaunay_triangulation_2.h>\n' | \
    $(CXX) -std=c++17 -x c++ -E - >/dev/null 2>&1 && echo yes)
endif
build/bench_plane: bench/plane.cpp pbw.h examples/lib/pbw_mesh2.h examples/lib/pbw_adapt2.h tests/inputs.h
	@mkdir -p build
	$(BENCH_CXX) $(if $(PLANE_HAS),-DBENCH_CGAL) $< -o $@ $(if $(PLANE_HAS),-lgmp -lmpfr) -lpthread -lm

.PHONY: bench-plane
bench-plane: build/bench_plane
	$< $(ARGS)

# Plane domains of tests/domains.h, refined: bench/domains.c;  ARGS="wedge comb" for some of them
build/bench_domains: bench/domains.c tests/domains.h $(HEADERS)
	@mkdir -p build
	$(BENCH_C) -I. -Iexamples/lib -Itests $< -o $@ -lpthread -lm

.PHONY: bench-domains
bench-domains: build/bench_domains
	$< $(ARGS)

# Solids beside CGAL, Gmsh and TetGen: bench/solid.cpp;  make bench-solid MODEL=part.off SIZES="0.1 0.05"
build/bench_solid: bench/solid.cpp examples/lib/pbw_surface.h examples/lib/pbw_improve.h examples/lib/pbw_mesh3.h \
    $(BENCH_INPUTS)
	@mkdir -p build
	$(CXX) -std=c++17 -frounding-math $(BENCH_FLAGS) -DNDEBUG -I. -Iexamples/lib $< -o $@ -ltet -lgmp -lmpfr \
	    -lpthread -lm

.PHONY: bench-solid
bench-solid: build/bench_solid
	$< $(MODEL) $(SIZES)

# Solids of the parts in tests/parts.h, each even and turned; ARGS="gear shell" for some of them
build/corpus: bench/corpus.c tests/parts.h $(HEADERS)
	@mkdir -p build
	$C -Itests $< -o $@ $(LIBS)

.PHONY: bench-corpus
bench-corpus: build/corpus
	$< $(ARGS)

# Tiles: what one rank of many sends and receives, by the work of a few of them: bench/tiles.c
build/bench_tiles: bench/tiles.c $(HEADERS)
	@mkdir -p build
	$C -Itests $< -o $@ $(LIBS)

bench-tiles: build/bench_tiles
	$< 1000 10000
	$< 1000 10000 clusters
	$< 10000 1000
	$< 64 200000 uniform 16
	$< 8 400000
.PHONY: bench-tiles

# Queries, cells, live batches and solids on more and more threads: bench/scaling.c
build/bench_scaling: bench/scaling.c $(HEADERS)
	@mkdir -p build
	$(BENCH_C) -D_POSIX_C_SOURCE=200809L -I. -Iexamples/lib $< -o $@ $(LIBS)

.PHONY: bench-scaling
bench-scaling: build/bench_scaling
	$< $(ARGS)

# Ranks beside as many threads, halo and memory a rank, out of core: bench/ranks.sh; ARGS="COUNT SCRATCH" for others
build/bench_ranks: bench/ranks.c pbw.h
	@mkdir -p build
	$C $< -o $@ $(LIBS)

bench-ranks: build/bench_ranks build/bench_tiles build/pbw build/mpi
	sh bench/ranks.sh build $(ARGS)
.PHONY: bench-ranks

# Live triangulations beside CGAL's insert, remove and move: bench/live.cpp
build/bench_live: bench/live.cpp examples/lib/pbw_live.h $(BENCH_INPUTS)
	@mkdir -p build
	$(CXX) -std=c++17 -frounding-math $(BENCH_FLAGS) -DNDEBUG -I. -Iexamples/lib $< -o $@ -lgmp -lmpfr -lpthread -lm

.PHONY: bench-live
bench-live: build/bench_live
	$< $(POINTS)

# Each number that is demanded of live triangulations, and whether it is reached: bench/live.c
build/bench_live_goals: bench/live.c examples/swarm.h $(HEADERS)
	@mkdir -p build
	$(BENCH_C) -D_POSIX_C_SOURCE=200809L -I. -Iexamples/lib $< -o $@ $(LIBS)

.PHONY: bench-live-goals
bench-live-goals: build/bench_live_goals
	$< $(ARGS)

# pbw solid on all surfaces of CGAL's demo data, or on MODELS, beside Gmsh and TetGen: bench/models.sh
.PHONY: bench-models
bench-models: $B/pbw
	sh bench/models.sh $< $(MODELS)

# pbw wrap beside CGAL's alpha wrap: bench/wrap.sh
build/bench_wrap: bench/wrap.cpp
	@mkdir -p build
	$(CXX) -std=c++17 -frounding-math $(BENCH_FLAGS) -DNDEBUG $< -o $@ -lgmp -lmpfr

.PHONY: bench-wrap
bench-wrap: $B/pbw build/bench_wrap
	sh bench/wrap.sh $B/pbw build/bench_wrap $(MODELS)

# Wraps of all surfaces of CGAL's demo data, or of MODELS, checked exactly: bench/wraps.c
build/bench_wraps: bench/wraps.c tests/wraps.h $(HEADERS)
	@mkdir -p build
	$(BENCH_C) -I. -Iexamples/lib $< -o $@ $B/companions.a $B/libpbw.a $(LIBS)

.PHONY: bench-wraps
bench-wraps: $B/companions.a $B/libpbw.a build/bench_wraps
	sh bench/wraps.sh build/bench_wraps $(MODELS)

# Pages of models that enclose nothing, their wraps and the tetrahedra in these, and of unions, in $B/gallery:
# bench/gallery.sh
.PHONY: bench-gallery
bench-gallery: $B/pbw
	sh bench/gallery.sh $< $B/gallery

# pbw fill beside TetGen: bench/fill.sh
.PHONY: bench-fill
bench-fill: $B/pbw
	sh bench/fill.sh $< $(MODELS)
