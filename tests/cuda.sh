#!/bin/sh
# cuda.sh FOLDER: pbw_cuda.cu compiles, where there is an nvcc; no GPU is needed.  make cuda-test runs it on one.
work=${1:-build}/cuda
. tests/check.sh
for nvcc in "${NVCC:-nvcc}" /usr/local/cuda/bin/nvcc ""; do
    [ -z "$nvcc" ] || ! command -v "$nvcc" > /dev/null || break
done
[ -n "$nvcc" ] || { skip "pbw_cuda.cu: no nvcc"; finish; }
compiles() { "$nvcc" -ptx -Xcicc -O0 -I. -Iexamples/lib "$1" -o "$work/kernels.ptx"; }
check "pbw_cuda.cu compiles" compiles pbw_cuda.cu
check "it has kernels" grep -q '[.]visible [.]entry' "$work/kernels.ptx"
finish
