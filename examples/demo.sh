#!/bin/sh
# demo.sh: makes a model, triangulates, checks, draws.  Usage: sh examples/demo.sh FOLDER, where FOLDER has pbw and model.
# Leaves its files in FOLDER/demo and says which they are.
set -e
bin=$1
out=$1/demo
mkdir -p "$out"

echo "== a knotted rope in 3D: surface and interior points; the tetrahedra inside, cut open"
"$bin/model" "$out/knot.obj" 0.5
"$bin/pbw" "$out/knot.obj" --inside --no-orphans -o "$out/knot.vtu" -o "$out/cut.svg"

echo "== the same, seen from above: the plane triangulation of its shadow"
"$bin/model" "$out/small.obj" 0.08
"$bin/pbw" "$out/small.obj" --dim 2 -o "$out/shadow.svg"

echo "== a ball, cut open"
"$bin/pbw" --generate ball 60000 -o "$out/ball.svg"

echo "== a sunflower"
"$bin/pbw" --generate spiral 4000 --dim 2 -o "$out/sunflower.svg"

echo "pictures (any browser): $out/cut.svg $out/shadow.svg $out/ball.svg $out/sunflower.svg"
echo "mesh (ParaView): $out/knot.vtu"
