#!/bin/sh
# csharp.sh FOLDER: examples/csharp/Pbw.cs, compiled by Mono's mcs and run on FOLDER/libpbw.so, where these are.
work=$1/csharp
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
here() { LD_LIBRARY_PATH="$(cd "$1" && pwd)" mono "$2"; }
here "$1" "$work/Pbw.exe" > "$work/printed" 2>&1
check "the example prints four triangles" \
    sh -c "grep -x '4 triangles' $work/printed && [ \$(grep -cE '^[0-4] [0-4] [0-4]\$' $work/printed) = 4 ]"
check "the tests pass" here "$1" "$work/tests.exe"
finish
