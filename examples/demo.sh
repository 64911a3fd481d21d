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
"$bin/pbw" sample "$out/knot.obj" --count 12000 --fill lattice -o "$out/points.ply"
"$bin/pbw" view "$out/points.ply" --quiet --points --title "Points on and in a knot" -o "$out/points.html"

echo "== the Delaunay triangulation of the points, proved; what is inside the model, for a simulator and for the eye"
"$bin/pbw" mesh "$out/points.ply" --inside --surface "$out/knot.obj" --no-orphans --title "A knot of tetrahedra" \
    --eye 0.1,-0.6,1 --cut 0.5,-0.8,0.3,0.25 -o "$out/knot.vtu" -o "$out/knot.msh" -o "$out/knot.html"

echo "== in the plane: a sunflower"
"$bin/pbw" view --generate spiral 4000 --quiet --dim 2 --title "A sunflower" -o "$out/sunflower.html"

echo "== a solid: the knot filled with tetrahedra whose dihedral angles are good"
"$bin/pbw" solid "$out/knot.obj" --size 0.17 --title "A knot of good tetrahedra" --eye 0.1,-0.6,1 \
    --cut 0.5,-0.8,0.3,0.25 -o "$out/solid.vtu" -o "$out/solid.msh" -o "$out/solid.html"

echo "meshes: $out/solid.vtu (ParaView) $out/solid.msh (Gmsh)"
echo "more pages: $out/points.html $out/knot.html $out/sunflower.html"
echo "open this in a browser: $out/solid.html"
