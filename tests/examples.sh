#!/bin/sh
# examples.sh FOLDER: runs the examples there that have a file in examples/expected, and compares what they print.
passed=0 failed=0
for expected in examples/expected/*.txt; do
    name=$(basename "$expected" .txt)
    if "./$1/$name" 2> "$1/$name.errors" | cmp -s - "$expected"; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED examples/$name.c"
        "./$1/$name" 2>&1 | diff - "$expected" | head -n 6
    fi
done
echo "$passed passed, $failed failed, 0 skipped"
[ "$failed" = 0 ]
