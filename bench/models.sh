#!/bin/sh
# models.sh PROGRAM [MODEL...]: `PROGRAM solid` at its default size on one thread, at most LIMIT seconds of processor
# time (default 60) a model; a line for each, and at the end how many are good, poor, not ended and refused.
# Without models: the surfaces of CGAL's demo data, from /usr/share/doc/libcgal-dev/data.tar.gz or the folder DATA.
#   good      a boundary that is a manifold with the Euler number of the surface, at most 0.15 sizes away (0.3 if it
#             has no sharp edges), dihedral angles of at least 20 degrees, or 9/10 of an acute edge's
#   refused   the program's message follows
pbw=$1
limit=${LIMIT:-60} data=${DATA:-/usr/share/doc/libcgal-dev/data.tar.gz}
shift || exit 2
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
if [ $# -eq 0 ]; then
    if [ -f "$data" ]; then
        tar xzf "$data" -C "$work" || exit 2
        data=$work
    fi
    [ -d "$data" ] || { echo "models.sh: $data: CGAL's demo data are not there"; exit 2; }
    find "$data" -name '*.off' | LC_ALL=C sort > "$work/list"
else
    printf '%s\n' "$@" > "$work/list"
fi

printf '%-34s %7s %9s %6s %8s  %s\n' model seconds tets angle distance verdict
while read -r model; do
    rm -f "$work/out.mesh"
    ( ulimit -t "$limit"; exec "$pbw" solid "$model" --threads 1 -o "$work/out.mesh" ) > "$work/report" 2>&1
    awk -v status=$? -v limit="$limit" -v model="$(basename "$model" .off)" '
        function row(verdict) { printf "%-34s %7s %9s %6s %8s  %s\n", model, seconds, tets, angle, distance, verdict }
        BEGIN { seconds = tets = angle = distance = "-"; acute = 180; most = 0.15 }
        /^(sample|rounds|improve|measure) / { seconds = sprintf("%.2f", seconds + $2) }
        /sharp edge/ && /^sample/ { sharp = $6; if (sharp == 0) most = 0.3 }
        / sharp edges?: (some|none)/ { if ($0 ~ /edges?: none/) most = 0.3 }
        / tetrahedra in / { tets = $1 }
        /^after: / { split($0, part, "angles "); angle = part[2] + 0 }
        /^Euler number/ { sub(/,/, "", $3); euler = $3; split($0, part, "surface "); right = part[2] + 0
                          split($0, part, "manifold "); faults = part[2] + 0; sub(/.*points /, ""); faults += $1 }
        /^Hausdorff/ { distance = $3 }
        /below 60 degrees/ { split($0, part, "least "); acute = part[2] + 0 }
        /Euler number of the boundary/ { wrong = 1 }
        { if ($0 != "") last = $0 }
        END {
            if (tets == "-" && status > 128) { seconds = limit; row("not ended"); exit }
            if (tets == "-") { sub(/^pbw: /, "", last); sub(/^.*[.]off: /, "", last); row("refused: " last); exit }
            least = acute < 60 && 0.9 * acute < 20 ? 0.9 * acute : 20
            why = (faults ? " faults " faults : "") (wrong ? " Euler " euler " of " right : "") \
                  (angle < least ? " angle" : "") (distance > most ? " distance" : "")
            row(why == "" ? "good" : "poor:" why)
        }' "$work/report"
done < "$work/list" | tee "$work/table"
awk '{ tail = substr($0, 70) } tail ~ /^ *good/ { good++ } tail ~ /^ *poor/ { poor++ } tail ~ /^ *not ended/ { late++ }
     tail ~ /^ *refused/ { refused++ }
     END { printf "%d good, %d poor, %d not ended, %d refused\n", good, poor, late, refused }' "$work/table"
