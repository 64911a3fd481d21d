#!/bin/sh
# plane.sh FOLDER: pbw plane: what it reads, refuses and writes.  Every check is of an exit status and of what is
# printed or written.
bin=$(cd "$1" && pwd)
pbw=$bin/pbw work=$bin/plane tests=$(pwd)/tests
. tests/check.sh
cd "$work" || exit 2

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

check "a .poly file with its .node file" says 0 "8 triangles, 8 points, 8 edges of segments, 1 region" plane plate.poly
check "a .geojson file" says 0 "8 triangles, 8 points, 8 edges of segments, 1 region" plane plate.geojson
printf '6 2 0 0\n1 0 0\n2 1 0\n3 2 0\n4 2 1\n5 1 1\n6 0 1\n7 0\n' > two.poly
printf '1 1 2\n2 2 3\n3 3 4\n4 4 5\n5 5 6\n6 6 1\n7 2 5\n0\n2\n1 .5 .5 7 0\n2 1.5 .5 9 0\n' >> two.poly
regions() { # of two.poly, in files
    says 0 ", 2 regions" plane two.poly -o two.ele -o two.msh2 -o two.inp -o two.vtu -o two.mesh &&
        awk 'NR > 1 { count[$NF]++ } END { exit count[7] != 2 || count[9] != 2 }' two.ele &&
        [ $(grep -c '^[0-9]* 2 2 7 7 ' two.msh2) = 2 ] && [ $(grep -c '^[0-9]* 2 2 9 9 ' two.msh2) = 2 ] &&
        grep -q 'ELSET=group_7' two.inp && grep -aq 'Name="region"' two.vtu && grep -q ' 9$' two.mesh
}
check "regions in files" regions
check "points" says 0 " 50 points" plane --generate uniform 50 --dim 2
check "angles" says 0 "0 triangles with smaller angles than wanted" plane plate.poly --angle 30 --area 0.1
check "a formula" says 0 "new points" plane plate.poly --size '0.1+0.1*hypot(x-1,y)'
check "crossings are refused" says 1 "segments 1 and 2 (lines 7 and 8) cross at (0.5, 0.5)" plane cross.poly
check "crossings are split" says 0 "5 points" plane cross.poly --split-crossings --rule hull
check "no formula" says 2 'this is no formula from "*x"' plane plate.poly --size '0.1+*x'
check "too large an angle" says 2 "up to 34" plane plate.poly --angle 40
check "a segment without its point" says 1 "wrong.poly:6: a segment from point 1 to point 4" plane wrong.poly
check "a file that ends too early" says 1 "cut.poly:" plane cut.poly
check "a bad .geojson file" says 1 "wrong.geojson:1:" plane wrong.geojson
check "no such file" says 1 "No such file" plane none.poly
check "how long a .poly file takes to read" says 0 "read  " plane plate.poly
check "reading .poly keeps --memory-limit" says 1 "plate.poly: out of memory within --memory-limit 10" plane plate.poly \
    --memory-limit 10
check "the boundary is kept" says 0 " 8 edges of segments" plane plate.poly --area 0.5 --keep-segments
check "what that prevents is told" grep "^0 new points, 0 more removed again; 0 triangles .*, 5 larger" said
awk 'BEGIN { print "17 2 0 0"; for (i = 0; i < 16; i++) { s = int(i / 4); t = i % 4
        print i + 1, (s == 0 ? t : s == 1 ? 4 : s == 2 ? 4 - t : 0), (s == 0 ? 0 : s == 1 ? t : s == 2 ? 4 : 4 - t) }
    print 17, 2, 2; print "17 0"; for (i = 0; i < 16; i++) print i + 1, i + 1, (i + 1) % 16 + 1; print 17, 3, 17
    print 0 }' > square.poly
kept() {    # kept EDGES OPTION...: new points inside, and so many edges of segments
    edges=$1
    shift
    says 0 " new points, " plane square.poly --area 0.1 "$@" && grep " $edges edges of segments" said
}
check "--keep-segments" kept 17 --keep-segments
split() { ! kept 17 "$@" && grep ' new points' said; }
check "--keep-boundary lets other segments be split" split --keep-boundary
check "the boundary is split else" split
bounded() { says 0 "; --steiner ended it" plane square.poly --area 0.01 --steiner 7 && grep '^7 new points' said; }
check "--steiner" bounded
cp square.poly tiny.poly
printf '1\n1 0.9 0.9 0 1e-160\n' >> tiny.poly
most() {    # most ARGUMENT...: refused before work
    says 1 " triangles, more than --most allows; larger sizes or a smaller angle need fewer" plane "$@" && ! grep mesh said
}
check "a tiny area of a region" most tiny.poly --angle 20
check "a tiny area" most square.poly --area 1e-160
check "a tiny size" most square.poly --size 1e-9
check "a tiny size by a formula" most square.poly --size 1e-9+0*x
check "--most" most square.poly --area 1e-3 --most 3000
check "--most, more" says 0 " triangles, " plane square.poly --area 1e-3 --most 30000
check "--most, met on the way" most square.poly --size "max(1e-9,abs(x-0.3)/100)" --most 3000
check "--most and --steiner" says 0 "; --steiner ended it" plane square.poly --area 1e-160 --steiner 7
printf '4 2 0 0\n1 0 0\n2 10 0\n3 5 0.2\n4 5 -0.2\n1 0\n1 1 2\n0\n' > across.poly
check "not conforming" says 0 "2 triangles, 4 points" plane across.poly --rule hull
check "--conforming" says 0 "4 triangles, 5 points" plane across.poly --rule hull --conforming
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
check "no such column" says 1 "there is no column" plane sized.poly --size '#9'
check "a column of a file that has none" says 1 ".geojson has none" plane plate.geojson --size depth
remesh() {  # a mesh is refined, and made coarse again
    "$pbw" plane plate.poly --angle 30 --area 0.01 --quiet -o fine.vtu && "$pbw" plane fine.vtu > plain &&
        "$pbw" plane fine.vtu --area 0.001 > finer && "$pbw" plane fine.vtu --size 1 --coarsen > coarse &&
        cat plain finer coarse && awk '/ triangles,/ { n[FILENAME] = $1 }
            END { exit !(n["finer"] > 4 * n["plain"] && 10 * n["coarse"] < n["plain"]) }' finer plain coarse
}
check "triangles of a mesh, finer and coarser" remesh
check "--coarsen needs sizes" says 2 "needs --size" plane plate.poly --coarsen
for way in laplace lloyd odt; do
    check "smoothing: $way" says 0 "smoothed: mean of least angles" plane plate.poly --area 0.05 --smooth $way --rounds 2
done
check "measures" says 0 "gamma            least" plane plate.poly --quality

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

# ---- what points and segments of a .poly file carry

{ # a square and its centre: an attribute 10 x + 100 y, one that is not linear, markers, regions 7 and 2.5
    printf '6 2 2 1\n5 0 0 0 1 3\n6 4 0 40 2 3\n7 4 4 440 3 4\n8 0 4 400 4 4\n9 2 2 220 9 0\n10 2 0 20 1.5 0\n'
    printf '6 1\n5 5 10 7\n6 10 6 7\n7 6 7 8\n8 7 8 9\n9 8 5 -2\n10 10 7 0\n0\n2\n5 1 3 7 0\n6 3 .5 2.5 0\n'
} > carried.poly
carried() { # every output has the numbers that came in
    for f in node poly vtu mesh csv edge ele; do set -- "$@" -o c.$f; done
    says 0 "new points" plane carried.poly --size 0.7 --text "$@" &&
        head -7 c.node && awk 'NR == 1 { n = $1; ok = $2 == 2 && $3 == 2 && $4 == 1 }
            NR > 1 { d = $4 - 10 * $2 - 100 * $3; ok = ok && d < 1e-9 && d > -1e-9 && NF == 6 && $1 == NR + 3
                if (NR > 7 && $2 > 0 && $3 == 0) ok = ok && $6 == 7
                if (NR > 7 && $2 == 4) ok = ok && $6 == 8
                if (NR > 7 && $3 == 4 && $2 < 4) ok = ok && $6 == 9
                if (NR > 7 && $2 == 0) ok = ok && $6 == -2
                if (NR > 7 && $2 > 0 && $2 < 4 && $3 > 0 && $3 < 4) ok = ok && $6 == 0 }
            END { exit !ok }' c.node &&
        printf '5 0 0 0 1 3\n6 4 0 40 2 3\n7 4 4 440 3 4\n8 0 4 400 4 4\n9 2 2 220 9 0\n10 2 0 20 1.5 7\n' > given &&
        sed -n '2,7p' c.node | cmp - given && sed -n '2,7p' c.poly | cmp - given &&
        head -2 c.csv && [ "$(sed 1q c.csv)" = x,y,attribute_1,attribute_2,marker ] &&
        [ "$(sed -n 2p c.csv)" = 0,0,0,1,3 ] && grep -q 'Name="attribute_2"' c.vtu && grep -q 'Name="marker"' c.vtu &&
        grep -q '^0 0 3$' c.mesh &&
        awk 'NR > 1 { n[$5]++ } END { exit !(n[7] > 9 && n[8] > 9 && n[7] + n[8] == NR - 1) }' c.ele &&
        awk 'NR > 1 { n[$4]++ } END { exit !(n[7] > 1 && n[8] > 1 && n[9] > 1 && n[-2] > 1 &&
            n[7] + n[8] + n[9] + n[-2] == NR - 1) }' c.edge
}
check "attributes, markers and numbers go from a .poly to every output" carried
again() {   # written and read again, with nothing changed
    says 0 "2 regions" plane c.poly -o d.poly -o d.node && cmp c.node d.node && says 0 "2 regions" plane d.poly -o e.poly &&
        cmp d.poly e.poly && grep -q '^6 3 0.5 8 -1$' e.poly && grep -q '^5 1 3 7 -1$' e.poly
}
check "a .poly file that was written says the same" again
printf '5 2 1 0\n1 0 0 1\n2 4 0 2\n3 4 4 3\n4 0 4 4\n5 0 0 9\n0\n0\n' > twice.poly
twice() {
    says 0 "those of the first one count" plane twice.poly --rule hull -o w.node && [ "$(sed -n 6p w.node)" = "5 0 0 1 0" ]
}
check "points that coincide have the attribute of the first" twice
mixed() {   # a crossing has the mean of what its segments have there
    printf '4 2 1 0\n1 0 0 0\n2 4 4 4\n3 4 0 10\n4 0 4 20\n2 0\n1 1 2\n2 3 4\n0\n' > mixed.poly
    says 0 "5 points" plane mixed.poly --split-crossings --rule hull -o m.node && grep -q '^5 2 2 8.5 ' m.node
}
check "the attribute of a crossing" mixed
printf '2 2 1 0\n1 0 0\n' > short.poly
check "an attribute that is missing" says 1 "short.poly:2: 0 attributes, 1 announced" plane short.poly
printf '3 2 0 1\n1 0 0 1.5\n' > half.poly
check "a marker that is no whole number" says 1 "half.poly:2: the marker 1.5" plane half.poly
printf '3 3 0 1\n1 0 0 1 1\n' > solid.poly
check "points in space" says 1 "solid.poly:1: the dimension 2 is needed" plane solid.poly
printf '3 2 0 0\n1 0 nan\n2 1 0\n3 0 1\n0\n0\n' > nan.poly
check "coordinates that are no numbers" says 1 "nan.poly:2: a point with its number, x and y" plane nan.poly
printf '3 2 0 0\n1 0 0 5\n2 1 0 5\n3 0 1 5\n0\n0\n' > more.poly
check "numbers that are not announced" says 0 "numbers behind points" plane more.poly --rule hull
gzip -kf plate.poly && cp plate.node plate2.node && gzip -kf plate.geojson
check "packed files" says 0 "8 triangles, 8 points, 8 edges of segments, 1 region" plane plate.poly.gz
check "packed GeoJSON" says 0 "8 triangles, 8 points, 8 edges of segments, 1 region" plane plate.geojson.gz
check "what a format has no place for" says 0 \
    "c.svg: the format .svg has no place for: markers of points, an attribute, an attribute" plane carried.poly -o c.svg
printf '5 2 0 0\n0 19 18\n1 0 0\n2 5 0\n3 5 5\n4 0 5\n4 0\n0 1 2\n1 2 3\n2 3 4\n3 4 1\n0\n' > far.poly
orphans() { # one numbering in all files
    says 0 "2 triangles, 4 points" plane far.poly --no-orphans -o f.node -o f.ele -o f.poly &&
        sed -n 2,5p f.node > one && sed -n 2,5p f.poly > two && cmp one two && ! grep 19 f.poly &&
        awk 'NR == 1 { n = $1 } NR > 1 { for (i = 2; i < 5; i++) if ($i > 3) exit 1 }' f.ele &&
        awk '$1 == 4 && NF == 2 { on = 1; next } on && NF == 4 { if ($2 > 3 || $3 > 3) exit 1 }' f.poly
}
check "--no-orphans numbers all files alike" orphans
beside() {  # elements come with points, unless those are named, or would replace an input
    rm -f g.node h.node && says 0 "g.node" plane plate.geojson -o g.ele && [ -s g.node ] &&
        says 0 "k.node" plane plate.geojson -o h.ele -o k.node && [ ! -e h.node ] &&
        cp g.node in.node && says 2 "which is an input and would be lost" plane in.node -o in.ele && cmp g.node in.node &&
        says 2 "it is an input" plane plate.poly -o plate.node
}
check "elements are written with their points" beside

# ---- GeoJSON: what it has, and how much of it is in the domain

json() {    # json TRIANGLES TEXT GEOJSON OPTION...: so many triangles, and a piece of what is said
    triangles=$1 text=$2
    printf '%s' "$3" > j.geojson
    shift 3
    says 0 "$text" plane j.geojson "$@" && grep -q "^$triangles triangle" said
}
refused() { # refused TEXT GEOJSON OPTION...: and no output
    text=$1
    printf '%s' "$2" > j.geojson
    shift 2
    rm -f no.ele no.node && says 1 "$text" plane j.geojson -o no.ele "$@" && [ ! -e no.ele ] && [ ! -e no.node ]
}
A='[[0,0],[4,0],[4,4],[0,4],[0,0]]' B='[[4,0],[8,0],[8,4],[4,4],[4,0]]' IN='[[1,1],[2,1],[2,2],[1,2],[1,1]]'
poly() { printf '{"type":"Polygon","coordinates":[%s]}' "$1"; }
feature() { printf '{"type":"Feature","properties":%s,"geometry":%s}' "$1" "$2"; }
all() { printf '{"type":"FeatureCollection","features":[%s]}' "$1"; }
line() { printf '{"type":"LineString","coordinates":%s}' "$1"; }
check "a MultiPoint" json 5 "5 points, 0 segments" \
    '{"type":"MultiPoint","coordinates":[[0,0],[8,0],[4,6],[2,2],[6,2]]}'
check "a Point in a Polygon" json 4 "5 points, 4 segments" \
    "$(all "$(feature '{}' "$(poly "$A")"),$(feature '{}' '{"type":"Point","coordinates":[2,2]}')")"
check "members in any order, escapes, strings with brackets" json 2 "4 points, 4 segments" \
    "{\"coordinates\":[$A], \"note\":\"]}\\\\\\\"{[\", \"\\u0074ype\":\"Pol\\u0079gon\"}"
check "a Feature that has its type last" json 2 "1 feature" \
    "{\"geometry\":$(poly "$A"),\"properties\":{\"coordinates\":[[9,9]],\"type\":\"Point\"},\"type\":\"Feature\"}"
check "a GeometryCollection in a GeometryCollection" json 4 "5 points, 4 segments, 1 polygon" \
    "{\"type\":\"GeometryCollection\",\"geometries\":[{\"type\":\"GeometryCollection\",\"geometries\":[$(poly "$A")]},
     {\"type\":\"Point\",\"coordinates\":[2,2]}]}"
check "a MultiPolygon" json 4 "8 points, 8 segments" "{\"type\":\"MultiPolygon\",\"coordinates\":[[$A],[$B]]}"
check "a hole" json 8 "8 edges of segments, 1 region" "$(poly "$A,$IN")"
check "an unclosed ring" json 3 "1 ring did not end where it began, and is closed" \
    "$(poly '[[0,0],[6,0],[6,5],[3,1],[0,5]]')"
check "a MultiLineString" json 8 "7 points, 6 segments" \
    '{"type":"MultiLineString","coordinates":[[[0,0],[4,0],[4,4],[0,4],[0,0]],[[1,1],[2,2],[3,1]]]}'
check "a line in a polygon bounds nothing" json 6 "6 points, 5 segments" "{\"type\":\"GeometryCollection\",
    \"geometries\":[$(poly "$A"),$(line '[[1,1],[3,3]]')]}"
check "a closed line in a polygon is no hole" json 10 "1 polygon" "{\"type\":\"GeometryCollection\",
    \"geometries\":[$(poly "$A"),$(line "$IN")]}"
check "closed lines as outlines" json 8 "8 points" "{\"type\":\"MultiLineString\",\"coordinates\":[$A,$IN]}" \
    --rule even-odd
check "lines take the hull, with a word" json 10 "the domain is the hull" \
    "{\"type\":\"MultiLineString\",\"coordinates\":[$A,$IN]}"
check "a feature a line" json 4 "2 features" "$(feature '{}' "$(poly "$A")")
$(feature null "$(poly "$B")")
"
check "a feature without geometry" json 2 "1 feature without a geometry" \
    "$(all "$(feature '{}' "$(poly "$A")"),$(feature '{}' null)")"
check "empty coordinates" json 2 "1 polygon" "$(all "$(feature '{}' "$(poly "$A")"),$(feature '{}' "$(poly '')")")"
check "nested features" json 8 "features 1 and 2 overlap around" \
    "$(all "$(feature '{}' "$(poly "$A")"),$(feature '{}' "$(poly "$IN")")")"
check "nested features, both" json 10 "the last one in the file names the region" \
    "$(all "$(feature '{}' "$(poly "$A")"),$(feature '{}' "$(poly "$IN")")")" --rule nonzero
check "rings that turn the wrong way" json 10 "overlap" \
    "$(all "$(feature '{}' "$(poly "$A")"),$(feature '{}' "$(poly '[[1,1],[1,2],[2,2],[2,1],[1,1]]')")")" \
    --rule nonzero
check "features that cancel each other out" refused "nothing is enclosed" \
    "$(all "$(feature '{}' "$(poly "$A")"),$(feature '{}' "$(poly "$A")")")"
check "and they are named" grep "features 1 and 2 overlap around" said
check "features that cross" refused "features 1 and 2 (lines 1 and 2) cross at (4, 2)" \
    "$(all "$(feature '{}' "$(poly "$A")"),
    $(feature '{}' "$(poly '[[3,2],[5,2],[5,3],[3,2]]')")")"
check "open lines" refused "segments end where no other goes on, at (0, 0), (4, 4)" \
    "$(line '[[0,0],[4,0],[4,4]]')" --rule even-odd
check "a ring of two corners" refused "j.geojson:1: a ring of 2 corners" "$(poly '[[0,0],[1,1],[0,0]]')"
check "a line of one position" refused "a line of 1 position" "$(line '[[0,0]]')"
check "a type that is none" refused '"Circle" is no type of a geometry, in feature 1' \
    "$(feature '{}' '{"type":"Circle","coordinates":[0,0]}')"
check "coordinates of another depth" refused '"coordinates" of a Polygon are lists, 2 deep' \
    '{"type":"Polygon","coordinates":[0,0]}'
check "too deep" refused 'a finite number is needed' "{\"type\":\"MultiPoint\",\"coordinates\":[[[0,0]]]}"
check "no number" refused "a finite number is needed" '{"type":"MultiPoint","coordinates":[[0,0],[NaN,1]]}'
check "too large a number" refused "a finite number is needed" '{"type":"MultiPoint","coordinates":[[0,0],[1e999,1]]}'
check "hexadecimal" refused "a finite number" '{"type":"MultiPoint","coordinates":[[0,0],[0x10,1]]}'
check "a trailing comma" refused "a finite number is needed" '{"type":"MultiPoint","coordinates":[[0,0],[1,1,]]}'
check "a file that ends too early" refused "ends inside" '{"type":"MultiPoint","coordinates":[[0,0],[1,1'
check "no GeoJSON" refused 'with its "type"' '{"rings":[[0,0],[1,1]]}'
check "no geometry" refused "there is no geometry" '{"type":"FeatureCollection","features":[]}'
check "an empty file" refused "the file is empty" ''
deep=$(printf '[%.0s' 1 2 3 4 5 6 7 8 9 10)
deep=$deep$deep$deep$deep$deep$deep$deep
check "brackets too deep" refused "brackets more than 64 deep" "{\"type\":\"Point\",\"x\":$deep"

regions() { # regions TAGS OPTION...: the tags of two polygons' triangles, as .poly has them
    tags=$1
    shift
    all "$(feature '{"n":12,"name":"wood \u00e4","mix":"a"}' "$(poly "$A")"),$(
        feature '{"n":-3,"name":"lake","mix":5}' "$(poly "$B")"),$(
        feature '{"x":1}' '{"type":"Point","coordinates":[1,2]}')" > r.geojson
    says 0 "2 regions" plane r.geojson "$@" -o r.poly && sed -n '/^2$/,$p' r.poly && tail -2 r.poly | awk '{ print $4 }' |
        sort -n | tr '\n' ' ' | grep -qx -- "$tags "
}
check "a feature is a region" regions "1 2"
check "--region-by a number" regions "-3 12" --region-by n
check "--region-by a name" regions "1 2" --region-by name
check "--region-by both" regions "5 6" --region-by mix
check "a feature without that property" grep 'without the property "mix"' said
check "no such property" says 1 'no feature has a property "none"; the first has "n", "name", "mix"' plane r.geojson \
    --region-by none
printf '[[0,0],[1,0],[0,1]]' > points.json
printf '{ "type" : "Feature", "properties": {"n": 7}, "geometry": {"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1],[0,0]]]}}' \
    > feature.json
gzip -c feature.json > feature2.geojson.gz
for file in feature.json feature2.geojson.gz; do
    check "GeoJSON in $file" says 0 "1 polygon, 1 feature" plane $file --region-by n -o feature.msh2
    check "has its regions" grep -q '^1 2 2 7 \|^[0-9]* 2 2 7 7 ' feature.msh2
done
check "JSON without features has no regions" says 1 "points.json: --region-by needs GeoJSON" plane points.json --region-by n -o n.msh
check "--region-by is for GeoJSON" says 2 "it needs an input .geojson" plane plate.poly --region-by n
hole() { says 0 "8 triangles" plane plate.geojson -o again.poly && says 0 "8 triangles" plane again.poly; }
check "a hole of GeoJSON is one in .poly" hole

# ---- heights

printf '{"type":"Polygon","coordinates":[[[0,0,1],[4,0,5],[4,4,13],[0,4,9],[0,0,1]]]}' > slope.geojson
heights() { # z = 1 + x + 2 y, at new points too
    for f in obj ply stl off vtu msh msh2 mesh csv inp poly node; do set -- "$@" -o s.$f; done
    says 0 "new points" plane slope.geojson --size 1 --text "$@" -o s.su2 -o s.html && tail -1 said &&
        awk '/^v / { d = $4 - 1 - $2 - 2 * $3; n++; if (d > 1e-9 || d < -1e-9) exit 1 } END { exit n < 9 }' s.obj &&
        awk 'NR > 1 { d = $4 - 1 - $2 - 2 * $3; if (d > 1e-9 || d < -1e-9) exit 1 }' s.node &&
        for f in ply off vtu msh msh2 mesh csv; do
            "$pbw" convert s.$f again.xyz --quiet --dim 3 || return 1
            awk '{ d = $3 - 1 - $1 - 2 * $2; if (d > 1e-9 || d < -1e-9 || NF != 3) exit 1 }' again.xyz || return 1
        done
}
check "heights go through, and to new points" heights
check "a word where there is no place for them" grep "s.su2: the format .su2 has no place for: heights" said
check "heights of some positions" json 2 "heights are left out: 2 of 5 positions have one" \
    "$(poly '[[0,0,1],[4,0],[4,4],[0,4],[0,0,1]]')"
kept() {    # a column of a table, at new points too
    printf 'x,y,depth,name\n0,0,0,a\n4,0,4,b\n4,4,8,c\n0,4,4,d\n' > kept.csv &&
        says 0 "new points" plane kept.csv --dim 2 --columns x,y --keep depth --size 1 -o kept2.csv &&
        [ "$(sed 1q kept2.csv)" = x,y,depth ] &&
        awk -F, 'NR > 1 { d = $3 - $1 - $2; if (d > 1e-9 || d < -1e-9) exit 1 } END { exit NR < 12 }' kept2.csv
}
check "--keep" kept
same() {
    "$pbw" plane s.obj --rule hull --dim 2 --quiet -o t.obj && grep '^v' s.obj | sort > one &&
        grep '^v' t.obj | sort | cmp - one
}
check "heights of a surface" same

# ---- regions and groups of a mesh

awk 'function node(i, j) { return 1 + i + 7 * j }
function line(a, b, tag) { all = all sprintf("%d 1 2 %d 1 %d %d\n", ++n, tag, a, b) }
function triangle(a, b, c, tag) { all = all sprintf("%d 2 2 %d 1 %d %d %d\n", ++n, tag, a, b, c) }
function point(a, tag) { all = all sprintf("%d 15 2 %d 1 %d\n", ++n, tag, a) }
BEGIN { print "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n6\n0 11 \"well\"\n0 12 \"gauge\"\n1 4 \"shore\""
    print "1 5 \"crack\"\n2 6 \"sand\"\n2 8 \"clay\"\n$EndPhysicalNames\n$Nodes\n21"
    for (j = 0; j < 3; j++) for (i = 0; i < 7; i++) print node(i, j), i + (j == 1 && i % 3 ? .2 : 0), j, 0
    for (i = 0; i < 6; i++) line(node(i, 0), node(i + 1, 0), 4)
    line(node(1, 1), node(2, 1), 5); point(node(4, 1), 11); point(node(6, 2), 12)
    for (j = 0; j < 2; j++) for (i = 0; i < 6; i++) {               # the second of two turns clockwise
        triangle(node(i, j), node(i + 1, j), node(i, j + 1), i < 3 ? 6 : 8)
        triangle(node(i, j + 1), node(i + 1, j + 1), node(i + 1, j), i < 3 ? 6 : 8) }
    print "$EndNodes\n$Elements\n" n; printf "%s", all; print "$EndElements" }' > fields.msh
cat > measure.awk << 'END'
# The measure of each group of a .msh 2.2, and how many triangles are on both sides of x = 3.
$1 == "$PhysicalNames" { getline; for (n = $1; n > 0; n--) { getline; name[$1 " " $2] = $3 } next }
$1 == "$Nodes" { getline; for (n = $1; n > 0; n--) { getline; x[$1] = $2; y[$1] = $3 } next }
$1 == "$Elements" { getline; for (n = $1; n > 0; n--) { getline; add() } next }
function add(    d, a, b, c, size) {
    d = $2 == 15 ? 0 : $2; a = $(4 + $3); b = $(5 + $3); c = $(6 + $3)
    size = d == 0 ? 1 : sqrt((x[b] - x[a]) ^ 2 + (y[b] - y[a]) ^ 2)
    if (d == 2) size = ((x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a])) / 2
    if (d == 2 && (x[a] < 3 || x[b] < 3 || x[c] < 3) && (x[a] > 3 || x[b] > 3 || x[c] > 3)) across++
    if ($4 != 0) sum[d " " $4] += size < 0 ? -size : size
}
END { for (g in sum) printf "%s %s %.9g\n", g, name[g], sum[g] | "sort"
    close("sort"); print across + 0 " across" }
END
groups_of() { "$pbw" convert "$1" --quiet -o of.msh2 && awk -f measure.awk of.msh2; }
printf '%s\n' '0 11 "well" 1' '0 12 "gauge" 1' '1 4 "shore" 6' '1 5 "crack" 1' '2 6 "sand" 6' '2 8 "clay" 6' \
    '0 across' > groups
sed 's/"[a-z]*"//' groups > tags                     # of formats without names
sed 's/[0-9]* "/"/' groups > names                   # of formats without tags
sed '/^[01] [1-9]/d' tags > regions                   # of formats without other groups
{
    printf '# vtk DataFile Version 3.0\nfields\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 21 double\n'
    sed -n '/^.Nodes/,/^.EndNodes/p' fields.msh | awk 'NF == 4 { print $2, $3, $4 }'
    printf 'CELLS 24 96\n'
    awk '$2 == 2 && NF == 8 { print 3, $6 - 1, $7 - 1, $8 - 1 }' fields.msh
    printf 'CELL_TYPES 24\n'
    awk '$2 == 2 && NF == 8 { print 5 }' fields.msh
    printf 'CELL_DATA 24\nSCALARS region int 1\nLOOKUP_TABLE default\n'
    awk '$2 == 2 && NF == 8 { print $4 }' fields.msh
} > fields.vtk
awk '/^.Nodes/ { on = 1; getline; print $1, 2, 1, 1; next } /^.EndNodes/ { on = 0 }         # an attribute 10 x + y
    on { print $1, $2, $3, 10 * $2 + $3, ($3 == 0 || $3 == 2 || $2 == 0 || $2 == 6) }' fields.msh > fields.node
awk 'BEGIN { print 24, 3, 1 } $2 == 2 && NF == 8 { print ++n, $6, $7, $8, $4 }' fields.msh > fields.ele
"$pbw" convert fields.msh --quiet -o of41.msh -o fields.vtu -o fields.mesh -o fields.inp
stays() {   # stays INPUT OUTPUT EXPECTED COMMAND OPTION...: the output has the groups that are expected
    input=$1 output=$2 expected=$3
    shift 3
    rm -f "$output"
    "$pbw" "$@" "$input" -o "$output" > said 2>&1 && groups_of "$output" > got || { cat said; return 1; }
    case $expected in
    tags) sed 's/"[a-z]*"//' got ;;
    regions) sed '/^[01] [1-9]/d; s/"[a-z]*"//' got ;;
    names) sed 's/[0-9]* "/"/' got ;;
    *) cat got ;;
    esac | diff "$expected" -
}
all_stay() {    # all_stay COMMAND OPTION...: from every format, to every format that has them
    stays fields.msh o1.msh2 groups "$@" && stays o1.msh2 o2.msh groups "$@" && stays o2.msh o3.vtu groups "$@" &&
        stays of41.msh o4.msh2 groups "$@" && stays fields.vtu o5.msh groups "$@" &&
        stays fields.mesh o6.mesh tags "$@" && stays fields.vtk o7.vtu regions "$@" &&
        stays fields.ele o8.ele regions "$@" && stays fields.inp o9.inp names "$@"
}
check "regions and groups stay: triangulated again" all_stay plane
in_full "regions and groups stay: --size" all_stay plane --size .5
in_full "regions and groups stay: --angle, --smooth" all_stay plane --angle 30 --smooth odt
check "regions and groups stay: --coarsen" all_stay plane --size 2 --coarsen
check "regions and groups stay: improve" all_stay improve
in_full "regions and groups stay: --only-smooth" all_stay improve --smooth lloyd --only-smooth
{   # a flat .stl of two solids: each triangle has its own corners
    for name in left right; do
        echo "solid $name"
        awk -v name=$name '$2 == 2 && NF == 8 && ($4 == 6) == (name == "left") { print $6, $7, $8 }' fields.msh |
            awk 'NR == FNR { if (NF == 4) { at[$1] = $2 " " $3 " 0" } next } { print "facet normal 0 0 1\nouter loop"
                for (k = 1; k < 4; k++) print "vertex", at[$k]
                print "endloop\nendfacet" }' fields.msh -
        echo "endsolid $name"
    done
} > fields.stl
printf 'v 0 0 2\nv 1 0 2\nv 2 0 2\nv 2 1 2\nv 1 1 2\nv 0 1 2\ng one\nf 1 2 5 6\ng two\nf 2 3 4 5\n' > parts.obj
parts() {   # groups of models are regions
    says 0 " 2 regions" plane fields.stl -o p.msh2 && groups_of p.msh2 > got && cat got && grep '^2 1 "left" 6$' got &&
        grep '^2 2 "right" 6$' got && grep '^1 4 "interface" 2$' got && "$pbw" improve parts.obj -o p.vtu --quiet &&
        groups_of p.vtu > got && cat got && grep '^2 1 "one" 1$' got && grep '^2 2 "two" 1$' got
}
check "solids of .stl and groups of .obj are regions" parts
well() { stays fields.msh o.msh2 groups "$@" && grep -q ' 4[.]2 1 0$' o.msh2; }
check "points of groups with a name do not move" well improve
check "nor in pbw plane" well plane --smooth lloyd
check "nor do they go" well plane --size 3 --coarsen
numbers() { # in .mesh, which has room for them
    sed '/^Triangles/,$ { s/ 6$/ -7/; s/ 8$/ 2000000000/; }' fields.mesh > far.mesh &&
        says 0 "2 regions" plane far.mesh -o far2.mesh && "$pbw" improve far2.mesh -o far3.mesh --quiet &&
        awk '/^Triangles/ { getline; left = $1; next } left > 0 { left--; n[$4]++ }
            END { exit !(n["-7"] == 12 && n[2000000000] == 12) }' far3.mesh
}
check "tags below 0, and large ones" numbers
linear() {  # an attribute of points, at new places too; markers on the boundary, and nowhere else
    "$pbw" "$@" fields.ele -o a.node --quiet && awk 'NR == 1 { ok = $3 == 1 && $4 == 1 && $1 > 20 }
        NR > 1 { d = $4 - 10 * $2 - $3; on = $3 == 0 || $3 == 2 || $2 == 0 || $2 == 6
            ok = ok && d < 1e-9 && d > -1e-9 && $5 == on } END { exit !ok }' a.node &&
        [ "$(sed -n 2p a.node)" = "1 0 0 0 1" ]
}
edges() {   # of Triangle's four files; new points have the marker of their edge where points have it
    mkdir -p four && awk 'NR > 1 && $3 == 0 { $NF = 4 } 1' fields.node > four/f.node && cp fields.ele four/f.ele &&
        awk 'BEGIN { print 7, 1 } $2 == 1 && NF == 7 { print ++n, $6 , $7, $4 }' fields.msh > four/f.edge &&
        "$pbw" plane four/f.ele --size .4 --quiet -o g.ele -o g.edge -o g.node && groups_of g.ele > got && cat got &&
        grep '^1 4  6$' got && grep '^1 5  1$' got && grep '^2 8  6$' got &&
        awk 'NR > 1 && ($3 == 0) != ($NF == 4) { exit 1 }' g.node
}
check "markers of .edge" edges
check "attributes and markers of .ele and .node" linear plane --size .4
check "the same, improved" linear improve
flat() {    # z of all points
    "$pbw" plane slope.geojson --size 1 --quiet -o slope.obj && sed '/^v/ s/ [^ ]*$/ 2.5/' slope.obj > flat.obj &&
        "$pbw" improve flat.obj --quiet -o flat2.obj &&
        awk '/^v / { n++; if ($4 != 2.5) exit 1 } END { exit n < 9 }' flat2.obj
}
check "a mesh of one z stays there" flat
in_poly() { # regions, markers and holes
    says 0 "2 regions" plane fields.msh --size .5 -o f.poly && says 0 "2 regions" plane f.poly -o f.msh2 &&
        groups_of f.msh2 > got && grep '^1 4  6$' got && grep '^1 5  1$' got && grep '^2 6  6$' got && grep '^2 8  6$' got &&
        grep '^0 12  1$' got && "$pbw" plane plate.poly --quiet -o holed.vtu &&
        "$pbw" plane holed.vtu -o holed2.poly --quiet &&
        says 0 "8 triangles, 8 points, 8 edges of segments, 1 region" plane holed2.poly
}
check "regions, markers and holes of a mesh go to .poly" in_poly
rule() {
    says 0 "the regions of triangles are left out" plane fields.msh --rule hull -o r.msh2 && groups_of r.msh2 > got &&
        cat got && grep -q '^1 5 "crack" 1$' got && ! grep '^2' got
}
check "--rule takes the points and segments of a mesh" rule
outside() { # a segment of a group that no triangle has
    awk '/^.Nodes/ { print; getline; print 23; next } /^.EndNodes/ { print "22 8 0 0\n23 9 0 0" }
        /^.Elements/ { print; getline; print $1 + 1; next } /^.EndElements/ { print "34 1 2 4 1 22 23" } 1' \
        fields.msh > lost.msh
    says 0 "1 of 8 segments are outside of the domain" plane lost.msh -o l.msh2 && groups_of l.msh2 > got &&
        diff groups got && "$pbw" improve lost.msh 2>&1 | grep "1 of 8 segments are outside"
}
check "a segment outside of the triangles" outside
over() {    # a triangle on others: its edge from (1, 0) to (6, 2) crosses the border at x = 3
    awk '/^.Elements/ { print; getline; print $1 + 1; next } /^.EndElements/ { print "34 2 2 8 1 2 21 15" } 1' \
        fields.msh > over.msh
    "$pbw" improve over.msh
    [ $? = 1 ] && says 1 "over.msh: borders of triangles, or segments, cross at (3, 0.8)" plane over.msh
}
check "triangles that lie on each other" over
lines() {   # a mesh of lines is a domain of segments, with their groups
    awk '/^.Elements/ { print; getline; print 9; next } $2 == 2 && NF == 8 { next } 1' fields.msh > lines.msh
    says 0 " 17 edges of segments" plane lines.msh -o l.msh2 --rule hull && groups_of l.msh2 | grep '^1 5 "crack" 1$'
}
check "segments of a mesh without triangles" lines
if command -v gmsh > /dev/null; then
    by_gmsh() {
        "$pbw" plane fields.msh --size .5 --quiet -o "$1" && gmsh "$1" -0 -v 1 -format msh2 -o g.msh2 &&
            awk -f measure.awk g.msh2 > got && diff groups got
    }
    check "Gmsh reads groups and names in .msh" by_gmsh b.msh
    check "Gmsh reads groups and names in .msh2" by_gmsh b.msh2
else
    skip "groups of a mesh: no Gmsh"
fi
cat > areas.py << 'END'
import sys

import meshio
import numpy as np

mesh = meshio.read(sys.argv[1])
for i, cells in enumerate(mesh.cells):
    tags = mesh.cell_data[sys.argv[2 if cells.type == "triangle" else -1]][i].reshape(-1)
    p = mesh.points[cells.data][:, :, :2]
    if cells.type == "triangle":
        d = p[:, 1:] - p[:, :1]
        size = abs(d[:, 0, 0] * d[:, 1, 1] - d[:, 0, 1] * d[:, 1, 0]) / 2
        assert all(abs(size[tags == group].sum() - 6) < 1e-9 for group in (6, 8))
    elif cells.type == "line":
        size = np.hypot(*(p[:, 1] - p[:, 0]).T)
        assert abs(size[tags == 5].sum() - 1) < 1e-9
END
for python in "${PYTHON:-python3}" /usr/bin/python3 none; do
    "$python" -c "import meshio" > /dev/null 2>&1 && break
done
if [ "$python" != none ]; then
    by_meshio() {
        "$pbw" plane fields.msh --size .5 --quiet -o b.msh2 -o b.vtu -o b.mesh && mv b.msh2 b2.msh &&
            "$python" areas.py b2.msh gmsh:physical && "$python" areas.py b.vtu region patch &&
            "$python" areas.py b.mesh medit:ref
    }
    check "meshio reads the regions and groups of a mesh" by_meshio
else
    skip "regions and groups of a mesh: no meshio"
fi

# ---- GeoJSON that is written

cat > features.py << 'EOF'
import json
import sys

def area(ring):
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, ring[1:])) / 2

path, whole, count, names = sys.argv[1], float(sys.argv[2]), int(sys.argv[3]), sys.argv[4:]
features = json.load(open(path))["features"]
assert len(features) == count, len(features)
total, ids = 0, set()
for feature in features:
    geometry, properties = feature["geometry"], feature["properties"]
    parts = geometry["coordinates"] if geometry["type"] == "MultiPolygon" else [geometry["coordinates"]]
    for rings in parts:
        assert all(ring[0] == ring[-1] and len(ring) > 3 for ring in rings)
        assert area(rings[0]) > 0 and all(area(ring) < 0 for ring in rings[1:])
    own = sum(area(ring) for rings in parts for ring in rings)
    assert abs(own - properties["area"]) < 1e-12, (own, properties)
    total += own
    ids.add(properties["id"])
    for name in names:
        key, value = name.split("=")
        assert str(properties[key]) in value.split("|"), properties
assert abs(total - whole) < 1e-12 and len(ids) == count, total
EOF
features() { "$python" features.py "$@"; }
printf 'x,y\n.5,.5\n3,3\n1.5,1.5\n3.9,0.1\n' > sites.csv
printf 'x,y\n.5,1.5\n1.5,1.5\n2.5,1.5\n40,1\n41,3\n' > ends.csv        # with a cell that has a hole
poly "$A,$IN" > holed.geojson
poly '[[0,0],[9,0],[9,9],[0,9],[0,0]],[[1,1],[8,1],[8,8],[1,8],[1,1]]' > frame.geojson
printf 'x,y\n20,5\n30,5\n20,30\n' > far.csv
written() {
    "$pbw" plane holed.geojson --size .5 --quiet -o w.geojson && n=$(grep -c Polygon w.geojson) &&
        features w.geojson 15 "$n" && "$pbw" plane w.geojson -o x.geojson | grep -qF " $n polygons, $n features" &&
        "$pbw" plane r.geojson --region-by name -o y.geojson --quiet &&
        features y.geojson 32 6 'region=1|2' 'name=wood ä|lake' &&
        "$pbw" mesh sized.csv --columns x,y -o z.geojson --quiet && features z.geojson 12 2 &&
        "$pbw" cells sites.csv --clip holed.geojson -o c.geojson --quiet && features c.geojson 15 4 &&
        "$pbw" cells ends.csv --clip holed.geojson -o d.geojson --quiet && features d.geojson 15 3 &&
        "$pbw" cells far.csv --clip frame.geojson -o e.geojson --quiet && features e.geojson 32 1 &&
        "$pbw" plane slope.geojson --size 1 --quiet -o s.geojson &&
        "$pbw" mesh s.geojson --quiet --dim 3 -o again.xyz &&
        awk '{ d = $3 - 1 - $1 - 2 * $2; if (d > 1e-9 || d < -1e-9 || NF != 3) exit 1 }' again.xyz
}
for python in "${PYTHON:-python3}" /usr/bin/python3 none; do
    "$python" -c "import json" > /dev/null 2>&1 && break
done
if [ "$python" = none ]; then
    skip "GeoJSON that is written: no Python"
else
    check "GeoJSON that is written: rings, areas, regions, heights" written
fi
check "GeoJSON of a mesh in space" eval '"$pbw" mesh --generate uniform 9 -o no.geojson 2> said; [ $? = 1 ] &&
    grep "no.geojson: GeoJSON holds polygons of the plane" said && [ ! -e no.geojson ]'
finish
