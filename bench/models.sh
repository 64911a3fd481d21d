#!/bin/sh
# models.sh PROGRAM [MODEL...]: `PROGRAM solid` at its default size on one thread, and Gmsh and TetGen at that size where
# they are installed, each for at most LIMIT seconds of processor time (default 60) a model, Gmsh and TetGen for
# RIVAL_LIMIT if that is given; JOBS models (1) at a time.  RIVALS= leaves the rivals out.  Where PROGRAM refuses, it runs
# with --wrap, too, if it has that; WRAPS= leaves this out.  A line for each, and at the end how many have which verdict.
# Without models: the surfaces of CGAL's demo data, from /usr/share/doc/libcgal-dev/data.tar.gz or the folder DATA.
#   good      a boundary that is a manifold with the Euler number of the surface, at most 0.15 sizes away (0.3 if it
#             has no sharp edges), dihedral angles of at least 20 degrees, or 9/10 of an acute edge's; of wraps: these
#             angles, and at most one size away
#   made      tetrahedra of a rival, which are not judged: its least angle is in the table
#   refused   the program's message follows
# Gmsh: surfaces classified by 40 degrees and meshed again.  TetGen: -pq1.4/15 with the volume of a regular
# tetrahedron; it keeps the facets.  Their seconds have reading and writing in them.
model=
if [ "$1" = --one ]; then       # models.sh --one PROGRAM MODEL: its rows, at once
    model=$(realpath "$3")
    shift
fi
pbw=$(realpath "$1")
shift || exit 2
. bench/common.sh

row() { printf '%-34s %-8s %8s %9s %6s %8s  %s\n' "$name" "$@"; }

# The row of a report of pbw solid.
judge() {   # judge PROGRAM-NAME STATUS
    awk -v status="$2" -v limit="$limit" -v model="$name" -v program="$1" '
        function row(verdict) {
            printf "%-34s %-8s %8s %9s %6s %8s  %s\n", model, program, seconds, tets, angle, distance, verdict
        }
        BEGIN { seconds = tets = angle = distance = "-"; acute = 180; most = 0.15 }
        /^(wrap|sample|rounds|improve|measure) / { seconds = sprintf("%.2f", seconds + $2) }
        /sharp edge/ && /^sample/ { sharp = $6; if (sharp == 0) most = 0.3 }
        / sharp edges?: (some|none)/ { if ($0 ~ /edges?: none/) most = 0.3 }
        / tetrahedra in / { tets = $1 }
        /^after: *dihedral/ { split($0, part, "angles "); angle = part[2] + 0 }
        /^Euler number/ { sub(/,/, "", $3); euler = $3; split($0, part, "surface "); right = part[2] + 0
                          split($0, part, "manifold "); faults = part[2] + 0; sub(/.*points /, ""); faults += $1 }
        /^Hausdorff/ { distance = $3 }
        /^[0-9]+ tetrahedra, / { tets = $1; most = 1 }
        /^after: *the boundary/ { distance = $7 }
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
}

solid() {   # solid PROGRAM-NAME OPTION...
    as=$1
    shift
    timed "$pbw" solid "$model" "$@" --threads 1 -o out.mesh
    judge "$as" "$code"
}

# Runs a rival and prints its row; MESH: what it writes.
rival() {   # rival NAME MESH COMMAND...
    as=$1 mesh=$2
    shift 2
    timed "$@"
    measure "$work/$mesh"
    if [ -n "$tets" ]; then
        row "$as" "$seconds" "$tets" "${angle:--}" - made
    else
        row "$as" "${seconds:-$limit}" - - - "$(failure "$code")"
    fi
}

one() {
    name=$(basename "$model" .off)
    solid pbw | tee "$work/row"
    if [ -n "${WRAPS-1}" ] && grep -q ' refused: ' "$work/row" && "$pbw" solid --help | grep -q -e ' --wrap'; then
        solid pbw-wrap --wrap
    fi
    [ -n "${RIVALS-1}" ] || return
    limit=${RIVAL_LIMIT:-$limit}
    cp "$model" "$work/in.off"
    size=$(diagonal "$model" | awk '{ printf "%.9g", $1 / 40 }')
    "$pbw" convert "$model" "$work/in.stl" > "$work/report" 2>&1 && [ -n "$size" ] || return
    if command -v gmsh > /dev/null; then
        printf '%s\n' 'Merge "in.stl";' 'ClassifySurfaces{40*Pi/180, 1, 1, Pi};' 'CreateGeometry;' \
            'Surface Loop(1) = Surface{:};' 'Volume(1) = {1};' "Mesh.MeshSizeMin = $size;" "Mesh.MeshSizeMax = $size;" \
            > "$work/in.geo"
        rival Gmsh out.msh gmsh in.geo -3 -nt 1 -v 2 -o out.msh
    fi
    if command -v tetgen > /dev/null; then
        rival TetGen in.1.ele tetgen "-pq1.4/15a$(awk -v h="$size" 'BEGIN { printf "%.9g", 0.11785113 * h ^ 3 }')" in.off
    fi
}

if [ -n "$model" ]; then
    one > "$work/rows"
    cat "$work/rows"
    exit
fi
list_models "$@"
name=model
row program seconds tets angle distance verdict
tr '\n' '\0' < "$work/list" | xargs -0 -n 1 -P "${JOBS:-1}" sh "$0" --one "$pbw" | tee "$work/table"
awk '{ sub(/:$/, "", $7); $7 = $7 == "not" ? "not ended" : $7; count[$2 ": " $7]++ }
     END { for (verdict in count) print verdict, count[verdict] }' "$work/table" | LC_ALL=C sort
