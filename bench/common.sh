# common.sh: what scripts of bench share, by `. bench/common.sh` once $pbw, the program, is named.
limit=${LIMIT:-60} data=${DATA:-/usr/share/doc/libcgal-dev/data.tar.gz}
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT

# Lists the models named, without any the surfaces of CGAL's demo data: of the package libcgal-demo, or the folder DATA.
list_models() { # list_models [MODEL...]: into $work/list
    if [ $# -eq 0 ]; then
        if [ -f "$data" ]; then
            tar xzf "$data" -C "$work" || exit 2
            data=$work
        fi
        [ -d "$data" ] || { echo "$data: CGAL's demo data are not there" >&2; exit 2; }
        find "$data" -name '*.off' | LC_ALL=C sort > "$work/list"
    else
        printf '%s\n' "$@" > "$work/list"
    fi
}
timed() {   # timed COMMAND...: in $work, within the limit; its output in $work/report, $code, $seconds of processor time
    rm -f "$work/seconds"
    ( cd "$work" && exec sh -c 'ulimit -t '"$limit"'; "$@"; code=$?; times > seconds; exit $code' sh "$@" ) \
        > "$work/report" 2>&1
    code=$?
    seconds=$(awk 'NR == 2 { gsub(/[ms]/, " "); printf "%.2f", 60 * $1 + $2 + 60 * $3 + $4 }' "$work/seconds")
}
measure() { # measure FILE: $tets, or facets, and the least dihedral $angle, empty if there are none
    "$pbw" check "$1" > "$work/checked" 2>&1
    tets=$(sed -n 's/.* \([0-9]*\) tetrahedr.*/\1/p' "$work/checked" | head -n 1)
    facets=$(sed -n 's/^[0-9]* points in 3D, \([0-9]*\) faces.*/\1/p' "$work/checked")
    angle=$(sed -n 's/^dihedral angles \([0-9.]*\),.*/\1/p' "$work/checked")
}
failure() { # failure CODE: why there is nothing, by the exit status and the words of $work/report
    if [ "$1" = 152 ] || [ "$1" = 137 ]; then
        echo "not ended"
    elif [ "$1" -gt 128 ]; then
        echo "crashed: signal $(($1 - 128))"
    else
        words=$(sed -n 's/^pbw: //p' "$work/report" | grep -v '^warning' | tail -n 1 | sed 's/^.*[.]off: //')
        [ -n "$words" ] || words=$(sed 's/^ *//; s/^\(Error\|Warning\) *: *//' "$work/report" |
            grep -i -E 'error|intersect|fail|invalid|could not|unable|cannot|no elements' |
            grep -v -E 'summary|[0-9] error|full log' | head -n 1 | cut -c 1-100)
        echo "refused: ${words:-no mesh}"
    fi
}
diagonal() { # diagonal MODEL: of the box around it
    "$pbw" convert "$1" "$work/box.xyz" > "$work/checked" 2>&1 && awk '
        { for (k = 1; k <= 3; k++) { if (NR == 1 || $k < low[k]) low[k] = $k; if (NR == 1 || $k > high[k]) high[k] = $k } }
        END { for (k = 1; k <= 3; k++) sum += (high[k] - low[k]) ^ 2; printf "%.9g", sqrt(sum) }' "$work/box.xyz"
}
