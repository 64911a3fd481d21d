#!/bin/sh
# arm.sh FOLDER: pbw.h on 64-bit Arm, by a cross compiler and an emulator of one: the same arrays as here, with vectors
# and without; signs; and what the compiler made of the vectors.  Run from the root.
CC=${CC:-cc} work=$1/arm cross=aarch64-linux-gnu
. tests/check.sh

case "$(uname -m)" in aarch64 | arm64) skip "arm.sh: this is a 64-bit Arm, where \`make test\` tests it"; finish ;; esac
for emulator in qemu-aarch64-static qemu-aarch64 ""; do
    [ -z "$emulator" ] || ! command -v $emulator > /dev/null || break
done
printf '#include <stdlib.h>\nint main(void) { return 0; }\n' > "$work/empty.c"
if ! $cross-gcc -static "$work/empty.c" -o "$work/empty" > /dev/null 2>&1; then
    skip "arm.sh: no $cross-gcc, or no library for it"
elif ! command -v $cross-objdump > /dev/null; then
    skip "arm.sh: no $cross-objdump"
elif [ -z "$emulator" ]; then
    skip "arm.sh: no qemu-aarch64"
fi
[ $skipped = 0 ] || finish

program() {     # program NAME COMPILER FLAGS... FILE: in the background
    name=$1
    shift
    "$@" -std=c99 -I. -o "$work/$name" -lpthread -lm &
}
hashes() { [ -s "$work/$1.txt" ] && awk -v n=$2 'NR % n == 1 || n == 1' "$work/here.txt" | diff - "$work/$1.txt"; }
signs() { tail -n 1 "$work/signs.txt" | grep ' passed, 0 failed, '; }
instructions() {    # instructions OBJECT FUNCTION PATTERN: how many there are, of all functions if there is no name
    $cross-objdump -d --no-show-raw-insn "$1" 2> /dev/null |
        awk -v f="<$2>:" -v p="$3" '/>:$/ { on = f == "<>:" || $2 == f }
            on && $0 ~ p { n++ } END { print NR ? n + 0 : "nothing" }'
}

program here $CC -O1 tests/hashes.c
program vectors $cross-gcc -O2 -static tests/hashes.c
program scalar $cross-gcc -O2 -static -DPBW_NO_SIMD tests/hashes.c
program signs $cross-gcc -O2 -static tests/test_predicates.c
printf 'double f(double a, double b, double c) { return a * b + c; }\n' > "$work/net.c"
cp examples/install/library.c "$work/whole.c"
$cross-gcc -O2 -c "$work/net.c" -o "$work/net.o" &
whole() { $cross-gcc "$@" -ffp-contract=fast -I. -Iexamples/lib -DPBW__FMA=0 -c "$work/whole.c" & }
whole -O3 -o "$work/O3.o"
whole -O1 -DPBW_NO_SIMD -o "$work/scalar.o"
wait
"$work/here" > "$work/here.txt" &
$emulator "$work/vectors" > "$work/vectors.txt" &
$emulator "$work/scalar" 4 > "$work/scalar.txt" &      # a program with vectors runs this code, too, where they doubt
$emulator "$work/signs" --count 100 > "$work/signs.txt" &
wait
check "the same arrays, with vectors" hashes vectors 1
check "the same arrays, without, of every fourth input" hashes scalar 4
check "signs" signs

# The kernels are there, and multiply and add four numbers at once.
for kernel in insert3 insert3_weighted insert2 insert2_weighted; do
    check "$kernel: fused operations on vectors" \
        [ "$(instructions "$work/vectors" pbw__${kernel}_simd 'fml[as]\tv[0-9]+[.]2d')" -ge 20 ]
done
check "PBW_NO_SIMD leaves none" [ "$(instructions "$work/scalar.o" "" 'pbw__.*_simd>:$')" = 0 ]

# No fused operation that was not asked for: see asm.sh.
fused='\tf(n?m(add|sub)|ml[as])\t'
check "a fused operation is seen" [ "$(instructions "$work/net.o" "" "$fused")" = 1 ]
for object in O3 scalar; do
    check "nothing is fused: $object" [ "$(instructions "$work/$object.o" "" "$fused")" = 0 ]
done
finish
