#!/bin/sh
# demo.sh: from a model to points to a triangulation to a picture.  Usage: sh examples/demo.sh FOLDER, where FOLDER has
# pbw and model.  Leaves its files in FOLDER/demo and says which one to open.
set -e
bin=$1
out=$1/demo
mkdir -p "$out"

echo "== a model: a rope tied into a knot, $out/knot.obj"
"$bin/model" "$out/knot.obj"

echo "== points: blue noise on its surface, a jittered lattice inside"
"$bin/pbw" sample "$out/knot.obj" --count 30000 --fill lattice -o "$out/points.ply"

echo "== the Delaunay triangulation of the points, proved; what is inside the model, for a simulator and for the eye"
"$bin/pbw" mesh "$out/points.ply" --inside --surface "$out/knot.obj" --no-orphans \
    -o "$out/knot.vtu" -o "$out/knot.msh" -o "$out/knot.svg"

echo "== in the plane: its shadow, and a sunflower"
"$bin/pbw" sample "$out/knot.obj" --quiet --count 5000 -o "$out/shadow.ply"
"$bin/pbw" mesh "$out/shadow.ply" --quiet --dim 2 -o "$out/shadow.svg"
"$bin/pbw" mesh --generate spiral 4000 --quiet --dim 2 -o "$out/sunflower.svg"

echo "more pictures: $out/shadow.svg $out/sunflower.svg"
echo "meshes: $out/knot.vtu (ParaView) $out/knot.msh (Gmsh)"
echo "open this in a browser: $out/knot.svg"
