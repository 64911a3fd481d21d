#!/bin/sh
# gappa.sh FOLDER: Gappa proves every error bound of pbw.h, pbw_query.h and pbw_live.h for the operations written there;
# tests/gappa.py says how.
# It must refuse smaller bounds and an additional operation.  Run from the root.
work=${1:-build}/gappa
. tests/check.sh
if ! command -v gappa > /dev/null || ! command -v python3 > /dev/null; then
    skip "gappa.sh: needs gappa and python3"
    finish
fi

cat pbw.h examples/lib/pbw_query.h examples/lib/pbw_live.h > "$work/all.h"
check "the bounds" python3 tests/gappa.py "$work/all.h" "$work/proofs.g"
cat "$work/out"
passed=$((passed + $(sed -n 's/ passed, .*//p' "$work/out" | tail -n 1)))
set -- 's/\(FILTER_POWER3_ERROR\) 412/\1 404/' 's/z1 \* s23/z1 * s23 * 1.5/' \
    's/\(PAIRS_POWER3_ERROR\) 6133/\1 6070/' 's/\(#define PBW__SPHERE_ERROR\) 5/\1 4/' \
    's/\(most 2^-9\)8 times/\19 times/' 's/\(REACH_ERROR\) 8/\1 6/' 's/\(DEPTH3_ERROR\) 4.7/\1 4.5/'
for change; do
    sed "$change" "$work/all.h" > "$work/changed.h"
    check "$change changes a header" sh -c "! cmp -s $work/all.h $work/changed.h"
    check "$change is refused" sh -c "! python3 tests/gappa.py $work/changed.h $work/changed.g first"
done
finish
