#!/bin/sh
# plane.sh FOLDER: pbw plane: what it reads, refuses and writes.  Every check is of an exit status and of what is
# printed or written.
bin=$(cd "$1" && pwd)
pbw=$bin/pbw work=$bin/plane tests=$(pwd)/tests
. tests/check.sh
cd "$work" || exit 2

says() {    # says STATUS TEXT ARGUMENT...
    status=$1 text=$2
    shift 2
    "$pbw" plane "$@" < /dev/null > said 2>&1
    code=$?
    cat said
    [ $code = "$status" ] && grep -qF -- "$text" said
}

printf '# a plate with a hole\n8 2 0 0\n1 0 0\n2 4 0\n3 4 3\n4 0 3\n5 1 1\n6 2 1\n7 2 2\n8 1 2\n' > plate.node
printf '0 2 0 0\n8 1\n1 1 2 3\n2 2 3 3\n3 3 4 3\n4 4 1 3\n' > plate.poly
printf '5 5 6 4\n6 6 7 4\n7 7 8 4\n8 8 5 4\n1\n1 1.5 1.5\n' >> plate.poly
printf '{"type":"Polygon","coordinates":[[[0,0],[4,0],[4,3],[0,3],[0,0]],\n' > plate.geojson
printf '[[1,1],[2,1],[2,2],[1,2],[1,1]]]}' >> plate.geojson
printf '4 2 0 0\n1 0 0\n2 1 1\n3 1 0\n4 0 1\n2 0\n1 1 2\n2 3 4\n0\n' > cross.poly
printf '3 2\n1 0 0\n2 1 0\n3 0 1\n1 0\n1 1 4\n' > wrong.poly
printf '{"coordinates":[[1,2],[3' > wrong.geojson
sed '$d' plate.poly > cut.poly
cp plate.node cut.node

check "a .poly file with its .node file" says 0 "8 triangles, 8 points, 8 edges of segments, 1 region" plate.poly
check "a .geojson file" says 0 "8 triangles, 8 points, 8 edges of segments, 1 region" plate.geojson
printf '6 2 0 0\n1 0 0\n2 1 0\n3 2 0\n4 2 1\n5 1 1\n6 0 1\n7 0\n' > two.poly
printf '1 1 2\n2 2 3\n3 3 4\n4 4 5\n5 5 6\n6 6 1\n7 2 5\n0\n2\n1 .5 .5 7 0\n2 1.5 .5 9 0\n' >> two.poly
regions() { # of two.poly, in files
    says 0 ", 2 regions" two.poly -o two.ele -o two.msh -o two.inp -o two.vtu -o two.mesh &&
        awk 'NR > 1 { count[$NF]++ } END { exit count[1] != 2 || count[2] != 2 }' two.ele &&
        grep -aq '"region_0"' two.msh && grep -aq '"region_1"' two.msh && grep -q 'ELSET=region_1' two.inp &&
        grep -aq 'Name="region"' two.vtu && grep -q ' 3$' two.mesh
}
check "regions in files" regions
check "points" says 0 " 50 points" --generate uniform 50 --dim 2
check "angles" says 0 "0 triangles with smaller angles than wanted" plate.poly --angle 30 --area 0.1
check "a formula" says 0 "new points" plate.poly --size '0.1+0.1*hypot(x-1,y)'
check "crossings are refused" says 1 "segments 0 and 1 cross" cross.poly
check "crossings are split" says 0 "5 points" cross.poly --split-crossings --rule hull
check "no formula" says 2 'this is no formula from "*x"' plate.poly --size '0.1+*x'
check "too large an angle" says 2 "up to 34" plate.poly --angle 40
check "a segment without its point" says 1 "wrong.poly:6: a segment from point 1 to point 4" wrong.poly
check "a file that ends too early" says 1 "cut.poly:" cut.poly
check "a bad .geojson file" says 1 "wrong.geojson:1:" wrong.geojson
check "no such file" says 1 "No such file" none.poly
check "the boundary is kept" says 0 " 8 edges of segments" plate.poly --area 0.5 --keep-segments
check "what that prevents is told" grep "^0 new points, 0 more removed again; 0 triangles .*, 5 larger" said
awk 'BEGIN { print "17 2 0 0"; for (i = 0; i < 16; i++) { s = int(i / 4); t = i % 4
        print i + 1, (s == 0 ? t : s == 1 ? 4 : s == 2 ? 4 - t : 0), (s == 0 ? 0 : s == 1 ? t : s == 2 ? 4 : 4 - t) }
    print 17, 2, 2; print "17 0"; for (i = 0; i < 16; i++) print i + 1, i + 1, (i + 1) % 16 + 1; print 17, 3, 17
    print 0 }' > square.poly
kept() {    # kept EDGES OPTION...: new points inside, and so many edges of segments
    edges=$1
    shift
    says 0 " new points, " square.poly --area 0.1 "$@" && grep " $edges edges of segments" said
}
check "--keep-segments" kept 17 --keep-segments
split() { ! kept 17 "$@" && grep ' new points' said; }
check "--keep-boundary lets other segments be split" split --keep-boundary
check "the boundary is split else" split
bounded() { says 0 "; --steiner ended it" square.poly --area 0.01 --steiner 7 && grep '^7 new points' said; }
check "--steiner" bounded
printf '4 2 0 0\n1 0 0\n2 10 0\n3 5 0.2\n4 5 -0.2\n1 0\n1 1 2\n0\n' > across.poly
check "not conforming" says 0 "2 triangles, 4 points" across.poly --rule hull
check "--conforming" says 0 "4 triangles, 5 points" across.poly --rule hull --conforming
counted() { "$pbw" plane plate.poly --histogram > said && awk '/^ *[0-9]*\.\./ { n += $2 } END { exit n != 8 }' said; }
check "--histogram" counted

printf '4 2 1 0\n1 0 0 0.1\n2 4 0 1\n3 4 3 1\n4 0 3 1\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n' > sized.poly
printf 'x,y,size\n0,0,0.1\n4,0,1\n4,3,1\n0,3,1\n' > sized.csv
grown() {   # the same sizes from a column by number and by name
    "$pbw" plane sized.poly --size '#3' --angle 30 | grep triangles, > one &&
        "$pbw" plane sized.csv --size size --angle 30 | grep triangles, > two && cmp one two &&
        awk '$2 < 100 { exit 1 }' one
}
check "sizes from a column" grown
graded() {  # slower growth, more triangles: of a column, of a formula
    for size in size 'max(0.1,10*(x-0.2))'; do
        "$pbw" plane sized.csv --size "$size" --gradation 0.05 | grep triangles, > one &&
            "$pbw" plane sized.csv --size "$size" --gradation 0.5 | grep triangles, > two && cat one two &&
            awk '{ n[FILENAME] = $1 } END { exit !(n["one"] > 1.5 * n["two"]) }' one two || return 1
    done
}
check "--gradation" graded
check "no such column" says 1 "there is no column" sized.poly --size '#9'
check "a column of a file that has none" says 1 ".geojson has none" plate.geojson --size depth
remesh() {  # a mesh is refined, and made coarse again
    "$pbw" plane plate.poly --angle 30 --area 0.01 --quiet -o fine.vtu && "$pbw" plane fine.vtu > plain &&
        "$pbw" plane fine.vtu --area 0.001 > finer && "$pbw" plane fine.vtu --size 1 --coarsen > coarse &&
        cat plain finer coarse && awk '/ triangles,/ { n[FILENAME] = $1 }
            END { exit !(n["finer"] > 4 * n["plain"] && 10 * n["coarse"] < n["plain"]) }' finer plain coarse
}
check "triangles of a mesh, finer and coarser" remesh
check "--coarsen needs sizes" says 2 "needs --size" plate.poly --coarsen
for way in laplace lloyd odt; do
    check "smoothing: $way" says 0 "smoothed: mean of least angles" plate.poly --area 0.05 --smooth $way --rounds 2
done
check "measures" says 0 "gamma            least" plate.poly --quality

# What VTK and Gmsh say of the quality of random triangles is what pbw plane says.
"$pbw" plane --generate uniform 2000 --dim 2 --quality -o q.vtu -o q.msh > quality
for python in "${PYTHON:-python3}" /usr/bin/python3 none; do
    "$python" -c "import numpy, vtk" > /dev/null 2>&1 && break
done
if [ "$python" = none ]; then
    skip "measures of quality: no Python with NumPy and VTK"
else
    check "measures of quality are Verdict's" "$python" "$tests/quality.py" quality q.vtu
fi
if command -v gmsh > /dev/null && /usr/bin/python3 -c "import numpy" > /dev/null 2>&1; then
    set -- -setnumber Print.PostElementary 0 -setnumber Print.PostElement 0 -setnumber Print.PostGamma 1
    gmsh q.msh -0 -v 1 "$@" -setnumber Print.PostSICN 1 -setnumber Print.PostSIGE 0 -format pos -o q.pos
    check "SICN and gamma are Gmsh's" /usr/bin/python3 "$tests/quality.py" quality q.pos
else
    skip "measures of quality: no Gmsh, or no Python with NumPy"
fi

outputs() {
    "$pbw" plane plate.poly --angle 30 --area 0.05 --quiet -o o.svg -o o.html -o o.poly -o o.vtu -o o.msh -o o.ele \
        -o o.node -o o.mesh && for file in o.svg o.html o.poly o.vtu o.msh o.ele o.node o.mesh; do
        [ -s $file ] || return 1
    done
}
check "outputs of all kinds" outputs
again() {   # what is written is read again as the same triangles
    "$pbw" plane plate.poly --angle 30 --area 0.05 | grep triangles, > one &&
        "$pbw" plane o.poly | grep triangles, > two && cmp one two
}
check "a .poly file that was written" again
markers() { awk 'NR > 1 && NF == 4 && $4 == 4' o.poly | grep . ; }
check "markers of segments are kept" markers
finish
