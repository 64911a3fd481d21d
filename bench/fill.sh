#!/bin/sh
# fill.sh PROGRAM [MODEL.off...]: `PROGRAM fill`, with --conforming where it has that, and TetGen's -p and -pY, where it is
# installed: the constrained tetrahedra of each model, on one thread, at most LIMIT seconds of processor time (60), with
# reading and writing; tetrahedra, least angle, or why there are none.  Without models: CGAL's demo data.
pbw=$(realpath "$1")
shift || exit 2
. bench/common.sh
list_models "$@"

row() { printf '%-34s %-16s %8s %9s %6s  %s\n' "$name" "$@"; }
fill() {    # fill NAME MESH COMMAND...
    as=$1 mesh=$2
    shift 2
    rm -f "$work/$mesh"
    timed "$@"
    measure "$work/$mesh"
    if [ "$code" = 0 ] && [ -n "$tets" ]; then
        row "$as" "$seconds" "$tets" "${angle:--}" made
    else
        row "$as" "$seconds" - - "$(failure "$code")"
    fi
}
name=model
row program seconds tets angle outcome
while read -r model; do
    name=$(basename "$model" .off) model=$(realpath "$model")
    fill pbw out.mesh "$pbw" fill "$model" --threads 1 -o out.mesh
    if "$pbw" fill --help | grep -q -e ' --conforming'; then
        fill pbw-conforming out.mesh "$pbw" fill "$model" --conforming --threads 1 -o out.mesh
    fi
    if command -v tetgen > /dev/null; then
        cp "$model" "$work/in.off"
        fill TetGen-p in.1.ele tetgen -p in.off
        fill TetGen-pY in.1.ele tetgen -pY in.off
    fi
done < "$work/list"
