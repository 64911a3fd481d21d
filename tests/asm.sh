#!/bin/sh
# asm.sh FOLDER: no compiler fuses a product into a sum behind our back, or takes MMX registers.  Run from the root, on
# x86-64, with libpbw.o and the companions' objects in FOLDER.
# PBW__FMA=0 takes out the fused operations that we ask for; then with -mfma allowed none may be left in any function.
# clang's -ffp-contract=fast overrides all pragmas: there fusing is allowed, and the predicates must bear it.
work=${1:-build}/asm
warn="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Werror"
passed=0 failed=0 skipped=0
rm -rf "$work" && mkdir -p "$work" || exit 2
cp examples/install/library.c "$work/whole.c"

fused() {   # fused OBJECT: function, instruction, count
    objdump -d --no-show-raw-insn "$1" |
        awk '/>:$/ { f = $2 } $2 ~ /^vf(n?m(add|sub)|maddsub|msubadd)[0-9]/ { n[f " " $2]++ }
             END { for (k in n) print "    " k, n[k] }'
}

finish() {
    echo "$passed passed, $failed failed, $skipped skipped"
    [ "$failed" = 0 ]
    exit
}

case "$(uname -m)" in x86_64 | amd64) ;; *) skipped=1; echo "skipped asm.sh: not x86-64"; finish ;; esac
if ! command -v objdump > /dev/null; then
    skipped=1
    echo "skipped asm.sh: no objdump"
    finish
fi

compilers=
for compiler in gcc clang; do
    if command -v $compiler > /dev/null; then
        compilers="$compilers $compiler"
    else
        skipped=$((skipped + 1))
        echo "skipped $compiler: not installed"
    fi
done

# The library and its companions as CC makes them: vectors are there, in registers of 128 bits and more.
for object in "${1:-build}/libpbw.o" "${1:-build}"/objects/library*.o; do
    objdump -d --no-show-raw-insn "$object" > "$work/code.s"
    if grep -q '%xmm[0-7]' "$work/code.s" && ! grep -q '%mm[0-7]' "$work/code.s"; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED $object: an MMX register, after which long doubles are NaN"
    fi
done

# The net must have no hole: products of this function may be fused, and are.
printf 'double f(double a, double b, double c) { return a * b + c; }\n' > "$work/net.c"
for compiler in $compilers; do
    $compiler -O2 -mfma -ffp-contract=fast -c "$work/net.c" -o "$work/net.o"
    if [ -n "$(fused "$work/net.o")" ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED $compiler: a fused operation is not seen"
    fi
    contract=-ffp-contract=fast ours=1  # gcc's own choice, too; what it does without our fma, its code above shows
    if $compiler --version | grep -q clang; then
        contract= ours="0 1"
    fi
    # At the highest level, with most instructions, the optimiser finds most to fuse, and perhaps something to warn of.
    flags="-O3 -mavx512f -mavx512dq -mavx512vl -mfma"
    # shellcheck disable=SC2086
    if $compiler -std=gnu99 $warn $flags $contract -I. -Iexamples/lib -DPBW__FMA=0 -c "$work/whole.c" \
            -o "$work/whole.o" && [ -z "$(fused "$work/whole.o")" ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED $compiler $flags $contract"
        fused "$work/whole.o"
    fi
    for fma in $ours; do
        flags="-O2 -mavx2 -mfma -ffp-contract=fast -DPBW__FMA=$fma"
        # shellcheck disable=SC2086
        if $compiler $flags tests/test_predicates.c -o "$work/test" -lm -lpthread &&
            "$work/test" --count 4000 > "$work/log"; then
            passed=$((passed + 1))
        else
            failed=$((failed + 1))
            echo "FAILED test_predicates, $compiler $flags: $(tail -n 1 "$work/log")"
        fi
    done
done
finish
