# cuda.mk: pbw_cuda.cu, included by the Makefile.
#   make cuda          compiles it where there is an nvcc: NVCC=, CUDA_FLAGS=-arch=sm_90
#   make cuda-test     compares it with the CPU on a GPU, then on small inputs under compute-sanitizer; runs the
#                      examples and tells whether this nvcc has a fault that pbw_cuda.cu avoids
#   make cuda-sanitize all of its tests under compute-sanitizer, side by side: tests/cuda_sanitize.py, ARGS=
#   make cuda-bench    measures it: ARGS=--quick, or KIND:DIM:COUNT[:w] ...
#   make cuda-cells-bench  measures its cells: ARGS=KIND:DIM:COUNT[:w] ...
#   make GPU=1 B=build/gpu  builds the pbw program and the Python library with it
NVCC ?= $(firstword $(shell command -v nvcc) $(wildcard /usr/local/cuda/bin/nvcc))
CUDA_HOME ?= $(patsubst %/bin/nvcc,%,$(NVCC))
CUDA_FLAGS ?= -O3
CUDA_C = $(CC) -std=c99 $(CFLAGS) $(WARN) -I. -Iexamples/lib -isystem $(CUDA_HOME)/include
CUDA_SANITIZER = $(firstword $(shell command -v compute-sanitizer) $(wildcard $(CUDA_HOME)/bin/compute-sanitizer))

.PHONY: cuda cuda-test cuda-sanitize cuda-bench cuda-cells-bench
$B/cuda.o: pbw_cuda.cu pbw.h examples/lib/pbw_check.h
	@mkdir -p $B
	$(NVCC) $(CUDA_FLAGS) -Xcompiler -fPIC -I. -Iexamples/lib -c $< -o $@

ifdef GPU
$B/pbw $B/libpbw_python.so: $B/cuda.o
$B/pbw $B/libpbw_python.so: private LIBS := $B/cuda.o -L$(CUDA_HOME)/lib64 -lcudart_static -lstdc++ -ldl -lrt $(LIBS)
$B/objects/gpu.o $B/libpbw_python.so: private C += -DPBW_CUDA
endif

$B/cuda_few.o: pbw_cuda.cu pbw.h examples/lib/pbw_check.h
	@mkdir -p $B
	$(NVCC) $(CUDA_FLAGS) -DPBW_CUDA_FEW=8 -DPBW_CUDA_TEST -I. -Iexamples/lib -c $< -o $@

$B/cuda_test: tests/cuda_test.c $(HEADERS) $B/cuda_few.o
	$(CUDA_C) -c $< -o $@.o
	$(NVCC) $(CUDA_FLAGS) -Xlinker --wrap=cudaMallocFromPoolAsync -Xlinker --wrap=cudaHostAlloc $@.o $B/cuda_few.o \
	    -o $@ -lpthread -lm

$B/cuda_bench: bench/cuda_bench.c $(HEADERS) $B/cuda.o $B/libpbw.a
	$(CUDA_C) -c $< -o $@.o
	$(NVCC) $(CUDA_FLAGS) $@.o $B/cuda.o $B/libpbw.a -o $@ -lpthread -lm

$B/cuda_cells: tests/cuda_cells.c $(HEADERS) $B/cuda_few.o
	$(CUDA_C) -c $< -o $@.o
	$(NVCC) $(CUDA_FLAGS) $@.o $B/cuda_few.o -o $@ -lpthread -lm

$B/cuda_cells_bench: bench/cuda_cells_bench.c $(HEADERS) $B/cuda.o $B/libpbw.a $B/companions.a
	$(CUDA_C) -c $< -o $@.o
	$(NVCC) $(CUDA_FLAGS) $@.o $B/cuda.o $B/companions.a $B/libpbw.a -o $@ -lpthread -lm

$B/cuda_inline: tests/cuda_inline.cu tests/test.h
	@mkdir -p $B
	$(NVCC) $(CUDA_FLAGS) $< -o $@

$B/gpu $B/lloyd_gpu: $B/%: examples/%.cu pbw.h $B/cuda.o
	$(NVCC) $(CUDA_FLAGS) -I. $< $B/cuda.o -o $@ -lpthread

ifeq ($(NVCC),)
cuda cuda-sanitize cuda-bench cuda-cells-bench:
	@echo 'skipped: no nvcc'
cuda-test:
	@echo 'skipped: no nvcc'
	@echo '0 passed, 0 failed, 1 skipped'
else
cuda: $B/cuda.o $B/gpu $B/lloyd_gpu
cuda-bench: $B/cuda_bench
	$B/cuda_bench $(ARGS)
cuda-cells-bench: $B/cuda_cells_bench
	$B/cuda_cells_bench $(ARGS)
cuda-sanitize: $B/cuda_test
	PATH="$$PATH:$(CUDA_HOME)/bin" python3 tests/cuda_sanitize.py $< --folder $B/cuda_sanitize $(ARGS)
cuda-test: $B/cuda_inline $B/cuda_test $B/cuda_cells $B/gpu $B/lloyd_gpu
	$B/cuda_inline
	$B/cuda_test $(COUNT:%=--count %)
	$B/cuda_cells
ifneq ($(CUDA_SANITIZER),)
	$(CUDA_SANITIZER) --tool memcheck --leak-check full --error-exitcode 1 $B/cuda_test --filter grids --count 5
	$(CUDA_SANITIZER) --tool memcheck --leak-check full --error-exitcode 1 $B/cuda_cells --filter uniform
	$(CUDA_SANITIZER) --tool racecheck --error-exitcode 1 $B/cuda_test --filter grids --count 3
	$(CUDA_SANITIZER) --tool synccheck --error-exitcode 1 $B/cuda_test --filter grids --count 3
	CUDA_TEST_LEAVE=1 $(CUDA_SANITIZER) --tool initcheck --error-exitcode 1 $B/cuda_test --filter grids --count 3
	CUDA_TEST_LEAVE=1 $(CUDA_SANITIZER) --tool initcheck --error-exitcode 1 $B/cuda_test --filter 'loop: 3D hidden'
endif
	$B/gpu | diff - examples/expected/gpu.txt
	$B/lloyd_gpu | diff - examples/expected/lloyd_gpu.txt
endif
