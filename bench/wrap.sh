#!/bin/sh
# wrap.sh PROGRAM RIVAL [MODEL.off...]: `PROGRAM wrap` and CGAL's alpha wrap, by bench/wrap.cpp, on one thread each, at
# most LIMIT seconds (60): seconds of processor time, of pbw with reading and writing; facets; facets a second.  alpha is
# each of the parts PARTS (20 50 100) of the diagonal, the offset 1/30 of it.  Without models: CGAL's demo data.
pbw=$(realpath "$1") rival=$(realpath "$2")
shift 2 || exit 2
. bench/common.sh
list_models "$@"

row() { printf '%-34s %5s %-8s %8s %9s %10s  %s\n' "$name" "$part" "$@"; }
made() {    # made NAME SURFACE SECONDS: the row of a run that ended with $code
    measure "$2"
    if [ "$code" = 0 ] && [ -n "$facets" ]; then
        row "$1" "$3" "$facets" "$(awk -v n="$facets" -v s="$3" 'BEGIN { printf "%.0f", n / (s > 0 ? s : 0.01) }')" made
    else
        row "$1" "$3" - - "$(failure "$code")"
    fi
}
name=model part=part
row program seconds facets "a second" outcome
while read -r model; do
    name=$(basename "$model" .off) model=$(realpath "$model")
    size=$(diagonal "$model")
    for part in ${PARTS:-20 50 100}; do
        alpha=$(awk -v d="$size" -v n="$part" 'BEGIN { printf "%.9g", d / n }')
        offset=$(awk -v a="$alpha" 'BEGIN { printf "%.9g", a / 30 }')
        rm -f "$work/wrap.off"
        timed "$pbw" wrap "$model" --alpha "$alpha" --offset "$offset" --threads 1 -o wrap.off
        made pbw "$work/wrap.off" "$seconds"
        rm -f "$work/wrap.off"
        timed "$rival" "$model" "$alpha" "$offset" wrap.off
        made CGAL "$work/wrap.off" "$(grep -x '[0-9.]*' "$work/report" || echo "$seconds")"
    done
done < "$work/list"
