#!/bin/sh
# campaign.sh FOLDER [COUNT]: mutations of every reader, faults and limits, with programs that `make campaign` built
# into FOLDER under sanitizers.  COUNT (1000) is how much; prints what each part did and its seconds.
bin=$(cd "$1" && pwd)
count=${2:-1000} work=$bin/campaign.files
. tests/check.sh
export ASAN_OPTIONS="exitcode=99:allocator_may_return_null=1" UBSAN_OPTIONS="halt_on_error=1:exitcode=99"

part() {    # part NAME COMMAND...: a program that ends with its counts
    name=$1 start=$(date +%s)
    shift
    if "$@" > "$work/part" 2>&1; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED $name"
        cp "$work/part" "$bin/campaign.failed"
    fi
    grep -v -e '^passed ' -e ' passed, ' "$work/part" | tail -n 40
    echo "$name: $(tail -n 1 "$work/part"), $(($(date +%s) - start)) s"
}

# Readers and calls, by bytes.
part "readers, $((20 * count)) damaged files" "$bin/fuzz_io_random" --count $((20 * count))
part "triangulations, $((20 * count)) inputs" "$bin/fuzz_triangulate_random" --count $((20 * count))
part "queries, $((5 * count)) inputs" "$bin/fuzz_query_random" --count $((5 * count))
part "live triangulations, $((5 * count)) inputs" "$bin/fuzz_live_random" --count $((5 * count))
part "cells, $count inputs" "$bin/fuzz_cells_random" --count "$count"
part "plane domains, $((2 * count)) inputs" "$bin/fuzz_plane_random" --count $((2 * count))
part "solids, $((count / 10)) inputs" "$bin/fuzz_solid_random" --count $((count / 10))

# Limits and misuse of the library.
for test in levels contract; do
    part "test_$test" "$bin/test_$test"
done
part "memory limits of planes" "$bin/test_adapt2" --filter "memory limit"
part "allocations of planes" "$bin/test_mesh2" --filter memory

# The program: damaged files, allocations, disks, streams, limits.
cd "$work" || exit 2
"$bin/pbw" mesh --generate uniform 60 --quiet -o m.csv -o m.obj -o m.stl -o m.ply -o m.off -o m.vtu -o m.msh \
    -o m.msh2 -o m.mesh -o m.node -o m.inp -o m.su2 -o m.xyz || exit 2
"$bin/pbw" mesh --generate uniform 60 --dim 2 --quiet -o p.csv -o p.obj -o p.vtu -o p.geojson || exit 2
"$bin/pbw" tiles m.csv --tiles 2 --quiet -o m.pbwt || exit 2
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n' > closed.obj
printf '{"type":"Polygon","coordinates":[[[0,0],[4,0],[4,3],[0,3],[0,0]],[[1,1],[1,2],[2,2],[1,1]]]}' > ring.geojson
cd "$bin/.." || exit 2
part "the program" "$bin/campaign" "$bin/pbw_failing" "$work" --count "$count"
finish
