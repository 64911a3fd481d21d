#!/bin/sh
# csharp.sh FOLDER: examples/csharp/Pbw.cs, compiled by Mono's mcs and run on FOLDER/libpbw.so, where these are.
CC=${CC:-cc} bin=$1 work=$1/csharp
. tests/check.sh
if ! command -v mcs > /dev/null; then
    skip "examples/csharp: no mcs"
    finish
fi
check "the example compiles" mcs -warn:4 -warnaserror -out:"$work/Pbw.exe" examples/csharp/Pbw.cs
check "the tests compile" \
    mcs -warn:4 -warnaserror -main:Tests -out:"$work/tests.exe" examples/csharp/Pbw.cs tests/csharp.cs
if ! command -v mono > /dev/null; then
    skip "examples/csharp runs: no mono"
    finish
fi
here() { LD_LIBRARY_PATH="$(cd "$bin" && pwd)" mono "$@"; }
here "$work/Pbw.exe" > "$work/printed" 2>&1
check "the example prints four triangles" \
    sh -c "grep -x '4 triangles' $work/printed && [ \$(grep -cE '^[0-4] [0-4] [0-4]\$' $work/printed) = 4 ]"
cat > "$work/sizes.c" << 'TEXT'
#include "pbw.h"
#include <stdio.h>
int main(void) { return printf("%zu %zu\n", sizeof(pbw_options), sizeof(pbw_mesh)) < 0; }
TEXT
check "sizes in C" $CC -I. "$work/sizes.c" -o "$work/sizes"
# shellcheck disable=SC2046
check "the tests pass" here "$work/tests.exe" $("$work/sizes")
finish
