#!/bin/sh
# hashes.sh: the same arrays, byte for byte, however pbw.h is compiled, and as they were stored.  Run from the root.
# With QUICK, by one compiler and in few ways.  The companion headers of examples/lib/, too, where processors fuse.
CC=${CC:-cc} work=${1:-build}/hashes
passed=0 failed=0 skipped=0
rm -rf "$work" && mkdir -p "$work" || exit 2

make_one() {   # make_one NAME COMPILER FLAGS...: in the background
    name=$1
    shift
    { "$@" -std=c99 tests/hashes.c -o "$work/$name" -lpthread -lm > "$work/$name.err" 2>&1 &&
        "$work/$name" > "$work/$name.txt" 2> "$work/$name.err"; } &
}

make_one reference $CC -O2 -DPBW__IMPLEMENTED "${1:-build}/libpbw.o"      # pbw.h as it is compiled already
make_one O0_scalar $CC -O0 -DPBW_NO_SIMD
make_one contracted $CC -O$([ -n "$QUICK" ] && echo 1 || echo 3) -march=native -ffp-contract=fast         # see below
[ -n "$QUICK" ] || make_one wide_threadless_scalar_unsigned_char_digits_of_26_bits $CC -O2 -DPBW_WIDE -DPBW_NO_THREADS \
    -DPBW_NO_SIMD -funsigned-char -U__SIZEOF_INT128__
wait
echo 'int main(void) { return 0; }' > "$work/empty.c"
if [ -n "$QUICK" ]; then
    :
elif $CC -m32 "$work/empty.c" -o "$work/empty" > /dev/null 2>&1; then
    make_one m32 $CC -m32 -msse2 -mfpmath=sse -O2
else
    skipped=$((skipped + 1))
    echo "skipped -m32: not installed"
fi
for compiler in ${QUICK:-gcc clang}; do
    if [ "$compiler" = 1 ]; then
        continue
    elif ! command -v $compiler > /dev/null; then
        skipped=$((skipped + 1))
        echo "skipped $compiler: not installed"
    elif [ "$compiler" != "$CC" ]; then
        make_one ${compiler}_O0 $compiler -O0
        make_one ${compiler}_scalar $compiler -O1 -DPBW_NO_SIMD
        make_one ${compiler}_native $compiler -O3 -march=native
        make_one ${compiler}_contracted $compiler -O1 -march=native -ffp-contract=fast
    fi
done
wait
# What the companion headers make, where processors fuse and gcc is not told by -std=c99 to leave that.
make_lib() {   # make_lib NAME SOURCE COMPILER FLAGS...
    name=$1 source=$2
    shift 2
    "$@" -std=gnu99 -I. -Iexamples/lib -Itests "$source" -o "$work/$name" $library -lpthread -lm \
        > "$work/$name.out" 2>&1 && "$work/$name" > "$work/$name.out" 2>&1
}
if [ -z "$QUICK" ]; then
    library="${1:-build}/companions.a ${1:-build}/libpbw.a"
    grep -v '_IMPLEMENTATION$' tests/hashes_lib.c > "$work/lib.c"       # what is compiled already
    make_lib lib "$work/lib.c" $CC -O1
    library=${1:-build}/libpbw.a
    for compiler in gcc clang; do
        level=-O3
        [ $compiler = clang ] || level=-O2
        if ! command -v $compiler > /dev/null; then
            skipped=$((skipped + 1))
            echo "skipped $compiler: not installed"
        elif make_lib lib_$compiler tests/hashes_lib.c $compiler $level -march=native && grep -q '^values: 0' "$work/lib.out" &&
                cmp -s "$work/lib.out" "$work/lib_$compiler.out"; then
            passed=$((passed + 1))
        else
            failed=$((failed + 1))
            echo "FAILED companion headers, $compiler $level -march=native"
            diff "$work/lib.out" "$work/lib_$compiler.out" | head -n 8
        fi
    done
fi
for errors in "$work"/*.err; do
    name=${errors%.err}
    if [ -s "$name.txt" ] && cmp -s "$work/reference.txt" "$name.txt"; then
        passed=$((passed + 1))
    elif [ -s "$name.txt" ] && [ "${name%contracted}" != "$name" ] && ! grep -qv ': 8 0 0 0 ' "$name.txt"; then
        passed=$((passed + 1))      # clang's fast overrides our pragma: PBW_ERROR_FP_MODE for all, as it should be
    else
        failed=$((failed + 1))
        echo "FAILED $(basename "$name"): $(diff "$work/reference.txt" "$name.txt" 2>&1 | grep -c '^>') lines differ"
        head -n 5 "$errors"
        diff "$work/reference.txt" "$name.txt" 2>&1 | head -n 4
    fi
done
if [ -s "$work/reference.txt" ] && ! grep '^CHANGED' "$work/reference.txt"; then
    passed=$((passed + 1))
else
    failed=$((failed + 1))
    echo "FAILED stored hashes.  If another order of the arrays is wanted, put the first hash of each line above"
    echo "into the table in tests/hashes.c.  The second is pbw_hash: where it differs, the triangulation does."
fi
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" = 0 ]
