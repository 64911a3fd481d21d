#!/bin/sh
# examples.sh FOLDER: runs the examples there that have a file in examples/expected, and compares what they print;
# then looks into the models and pictures that some of them write.  With QUICK it leaves out gas;
# without, it also compiles each as its user would, in one command with pbw.h inside, and runs some of these.
bin=$1 work=$1/examples
. tests/check.sh

prints() {   # prints PROGRAM FILE: and its exit status is 0
    "$1" > "$work/printed" 2> "$work/errors"
    code=$?
    diff "$work/printed" "$2" && [ $code = 0 ]
}

whole() {   # whole NAME FILE: compiles it in one command, which has pbw.h's implementation inside; runs a few
    set -- "$1" "$2" ${CC:-cc} -std=c99 -Iexamples/lib "examples/$1.c"
    [ ! -f "examples/$1.cpp" ] || set -- "$1" "$2" ${CXX:-c++} -std=c++11 "examples/$1.cpp"
    name=$1 printed=$2
    shift 2
    case $name in
    hello | raii) ;;
    *)
        "$@" -I. -fsyntax-only && { grep -q '^#define PBW_IMPLEMENTATION' "examples/$name".c* ||
            "$@" -I. -E | grep -q 'uint64_t pbw_hash(.*)$'; }
        return ;;
    esac
    "$@" -O0 -I. -o "$work/whole" -lpthread -lm && prints "$work/whole" "$printed"
}

# Every edge of an OBJ model is there once each way: its surface is closed and turned outward, or inward, all over.
closed() {
    awk '$1 == "f" { facets++; for (k = 2; k <= 4; k++) { b = k < 4 ? k + 1 : 2; edge[$k " " $b]++ } }
         END { if (facets < 4) { print facets " facets"; exit 1 }
               for (e in edge) { split(e, end, " ")
                   if (edge[e] != 1 || edge[end[2] " " end[1]] != 1) { print "edge " e; exit 1 } } }' "$1"
}

plays() {   # plays FRAMES LABEL PAGE: a whole page of so many frames
    [ "$(grep -c "<script.*data-label=.$2" "$3"),$(tail -n 1 "$3")" = "$1,</html>" ]
}

for expected in examples/expected/*.txt; do
    example=$(basename "$expected" .txt)
    [ ! -f "examples/$example.cu" ] || continue         # make cuda-test runs it
    if [ -f "examples/$example.cpp" ] && ! command -v ${CXX:-c++} > /dev/null; then
        skip "examples/$example.cpp: no C++ compiler"
    else
        [ "$example$QUICK" = gas1 ] || check "examples/$example" prints "$bin/$example" "$expected"
        in_full "examples/$example, compiled by itself" whole "$example" "$expected"
    fi
done

for model in hull alpha; do
    check "$model writes an OBJ model" "$bin/$model" "$work/$model.obj"
    check "$model: a closed surface" closed "$work/$model.obj"
    check "$model: no space left is an error" sh -c "[ ! -e /dev/full ] || ! $bin/$model /dev/full"
done
check "terrain writes a picture" "$bin/terrain" "$work/terrain.pgm"
check "terrain: of the size it says" [ "$(head -n 2 "$work/terrain.pgm" | tail -n 1),$(wc -c < "$work/terrain.pgm" |
    tr -d ' ')" = "720 480,345615" ]
check "terrain writes a page" "$bin/terrain" "$work/terrain.pgm" "$work/terrain.html"
check "terrain: a whole one" [ "$(tail -n 1 "$work/terrain.html")" = "</html>" ]
in_full "gas writes a page that plays" "$bin/gas" 100 "$work/gas.html"
in_full "gas: the first half" [ "$(cat "$work/out")" = "$(head -n 1 examples/expected/gas.txt)" ]
in_full "gas: of 125 frames, whole" plays 125 time "$work/gas.html"
check "swarm writes a page that plays" "$bin/swarm" 100 310 "$work/swarm.html"
check "swarm: of 155 frames, whole" plays 155 frame "$work/swarm.html"
check "front writes a page that plays" "$bin/front" "$work/front.html"
check "front: of 64 frames, whole" plays 64 time "$work/front.html"
for example in steps shares; do
    check "$example writes pictures" "$bin/$example" "$work/$example.svg"
    check "$example: three of them, whole" \
        [ "$(grep -c '<text' "$work/$example.svg"),$(tail -n 1 "$work/$example.svg")" = "3,</svg>" ]
    check "$example: no space left is an error" sh -c "[ ! -e /dev/full ] || ! $bin/$example /dev/full"
done
check "raster writes pictures" "$bin/raster" "$work/raster.pgm" "$work/linear.pgm"
check "raster: of the size it says" [ "$(head -n 2 "$work/linear.pgm" | tail -n 1),$(wc -c < "$work/linear.pgm" |
    tr -d ' ')" = "600 400,240015" ]
check "periodic writes a picture" "$bin/periodic" "$work/foam.svg"
check "periodic: each bubble in each of nine boxes" [ "$(grep -c '<path fill' "$work/foam.svg")" = 1080 ]
check "alpha_molecule writes a picture" "$bin/alpha_molecule" "$work/molecule.svg"
check "alpha_molecule: a whole one" [ "$(tail -n 1 "$work/molecule.svg")" = "</svg>" ]
for example in coast contour outlines breaklines; do
    check "$example writes a picture" "$bin/$example" "$work/$example.svg"
    check "$example: a whole one" \
        [ "$(grep -c '<path fill="#' "$work/$example.svg" | sed 's/[0-9]*[0-9]\{3\}$/many/'),$(
            tail -n 1 "$work/$example.svg")" = "many,</svg>" ]
done
LC_ALL=C awk 'BEGIN { printf "P5\n40 30\n255\n"; for (i = 0; i < 1200; i++)
    printf("%c", (i % 40 > 9 && i % 40 < 30 && i > 399 && i < 800) ? 200 : 1) }' > "$work/dark.pgm"
check "contour reads a PGM file" sh -c "$bin/contour $work/dark.svg $work/dark.pgm | grep '^1 parts, 19[0-9] pixels'"
head -c 1000 "$work/dark.pgm" > "$work/short.pgm"
check "contour refuses a short file" sh -c "! $bin/contour $work/dark.svg $work/short.pgm"
for example in raster periodic alpha_molecule coast contour outlines breaklines; do
    in_full "$example: no space left is an error" sh -c "[ ! -e /dev/full ] || ! $bin/$example /dev/full"
done
awk 'BEGIN { printf "P6\n# grey\n40 30\n255\n"; for (i = 0; i < 3600; i++) printf "%c", 48 + i % 75 }' \
    > "$work/in.ppm"
check "lowpoly reads a PPM file" "$bin/lowpoly" "$work/in.ppm" "$work/lowpoly.svg"
triangles=$(sed -n 's/.* \([0-9]*\) triangles.*/\1/p' "$work/out")
check "lowpoly: a path for each triangle" [ "$(grep -c '<path d=.*fill=.*/>' "$work/lowpoly.svg")" = "$triangles" ]
head -c 1000 "$work/in.ppm" > "$work/short.ppm"
check "lowpoly refuses a short file" sh -c "! $bin/lowpoly $work/short.ppm $work/short.svg"
finish
