#!/bin/sh
# queries.sh FOLDER: pbw locate, nearest and cells of FOLDER/pbw against answers computed here with awk: signs of
# determinants, distances to all points, volumes enclosed by facets; lattices, of which all is known.
bin=$(cd "$1" && pwd)
pbw=$bin/pbw work=$bin/queries
. tests/check.sh
cd "$work" || exit 2

early() { says "$@" && [ "$(wc -l < said)" = 1 ]; }
lines() { [ "$(grep -c "$1" "$2")" = "$3" ] || { grep -c "$1" "$2"; return 1; }; }

# located DIM: corners in l.csv are those of m.ele; a simplex has its query, and a facet of the hull sees it.
located() {
    awk -F, -v dim="$1" '
        function det(a, b, c, d) {       # six times the volume, in the plane twice the area
            if (dim == 2)
                return (x[b]-x[a])*(y[c]-y[a]) - (y[b]-y[a])*(x[c]-x[a])
            return (x[b]-x[a])*((y[c]-y[a])*(z[d]-z[a]) - (z[c]-z[a])*(y[d]-y[a])) \
                 - (y[b]-y[a])*((x[c]-x[a])*(z[d]-z[a]) - (z[c]-z[a])*(x[d]-x[a])) \
                 + (z[b]-z[a])*((x[c]-x[a])*(y[d]-y[a]) - (y[c]-y[a])*(x[d]-x[a]))
        }
        function bad(what) { print "query " $1 ": " what; wrong++ }
        FNR == 1 { file++; if (file != 3) next }
        file == 1 { x[FNR-2] = $1; y[FNR-2] = $2; z[FNR-2] = $3 }
        file == 2 { qx[FNR-2] = $1; qy[FNR-2] = $2; qz[FNR-2] = $3 }
        file == 3 && FNR > 1 {
            split($0, w, " ")
            row[w[1]] = w[2] "," w[3] "," w[4] (dim == 3 ? "," w[5] : "")
        }
        file == 4 {
            x["q"] = qx[$1]; y["q"] = qy[$1]; z["q"] = qz[$1]
            for (k = 0; k <= dim; k++) c[k] = $(3 + k)
            if ($2 < 0) {
                outside++
                count = 0
                for (k = 0; k < dim; k++) count += ($(3 + k) in x)
                if (count != dim || $(3 + dim) != -1) bad("no facet")
                low = high = 0       # all points are to one side of the facet, the query to the other
                for (p = 0; p in x; p++) {
                    s = dim == 3 ? det(c[0], c[1], c[2], p) : det(c[0], c[1], p)
                    low += s < -1e-12; high += s > 1e-12
                }
                s = dim == 3 ? det(c[0], c[1], c[2], "q") : det(c[0], c[1], "q")
                if ((low && high) || (s > 0) == (high > 0)) bad("a facet that does not see it")
            } else {
                inside++
                text = $3
                for (k = 1; k <= dim; k++) text = text "," c[k]
                if (text != row[$2]) bad("corners " text " are not " row[$2])
                for (k = 0; k <= dim; k++) {
                    keep = c[k]; c[k] = "q"
                    s = dim == 3 ? det(c[0], c[1], c[2], c[3]) : det(c[0], c[1], c[2])
                    if (s < -1e-14) bad("corner " k " is across")
                    c[k] = keep
                }
            }
        }
        END { print inside, outside; exit wrong || !inside || !outside || inside + outside != 60 }' \
        m.csv q.csv m.ele l.csv
}
# nearest DIM K [WEIGHTED]: for each query the K lines of n.csv are those of the least distances to all points.
nearest() {
    awk -F, -v dim="$1" -v k="$2" -v weighted="$3" '
        FNR == 1 { file++; next }
        file == 1 { x[n+0] = $1; y[n+0] = $2; z[n+0] = dim == 3 ? $3 : 0; w[n+0] = weighted ? $(dim + 1) : 0; n++ }
        file == 2 { qx[m+0] = $1; qy[m+0] = $2; qz[m+0] = dim == 3 ? $3 : 0; m++ }
        file == 3 { got[$1 "," $2] = $3; d[$1 "," $2] = $4; rows++ }
        function near(q, p) { return (x[p]-qx[q])^2 + (y[p]-qy[q])^2 + (z[p]-qz[q])^2 - w[p] }
        END {
            for (q = 0; q < m; q++) for (r = 0; r < k; r++) {
                p = got[q "," r]
                below = 0
                for (i = 0; i < n; i++) below += near(q, i) < near(q, p)
                here = weighted ? d[q "," r] : d[q "," r]^2
                if (below != r || (here - near(q, p))^2 > 1e-24) { print "query " q ", rank " r ": " below; wrong++ }
            }
            exit wrong || rows != m * k
        }' m.csv q.csv n.csv
}
# enclosed: the facets of each object of c.obj are closed, and enclose the volume of its line of c.csv.
enclosed() {
    awk '
        FNR == 1 { file++ }
        file == 1 { split($0, f, ","); if (FNR > 1) { volume[f[1]] = f[2]; cells += f[2] > 0 && f[2] != "inf" } }
        file == 2 && $1 == "v" { n++; x[n] = $2; y[n] = $3; z[n] = $4 }
        file == 2 && $1 == "o" { end(); id = substr($2, 6); objects++ }
        file == 2 && $1 == "f" {
            for (i = 3; i < NF; i++) {
                a = $2; b = $i; c = $(i + 1)
                sum += (x[a]*(y[b]*z[c]-z[b]*y[c]) - y[a]*(x[b]*z[c]-z[b]*x[c]) + z[a]*(x[b]*y[c]-y[b]*x[c])) / 6
            }
            for (i = 2; i <= NF; i++) {
                a = $i; b = i < NF ? $(i + 1) : $2
                edge[a " " b]++; edge[b " " a]--
            }
        }
        function end() {
            for (e in edge) { open += edge[e] != 0; delete edge[e] }
            if (id != "" && (sum - volume[id])^2 > (1e-10 + 2e-14 * volume[id])^2) { print "cell " id ": " sum ", not " volume[id]; wrong++ }
            sum = 0
        }
        END { end(); print objects, cells, open+0; exit wrong || open || !objects || objects != cells }' c.csv c.obj
}
# every FILE COLUMN VALUE: all lines but the head have it.
every() { awk -F, -v c="$2" -v v="$3" 'NR > 1 { n++; bad += ($c - v)^2 > 1e-24 } END { exit bad || !n }' "$1"; }

for dim in 2 3; do
    "$pbw" mesh --generate uniform 400 --dim $dim --quiet -o m.csv -o m.ele
    "$pbw" mesh --generate uniform 60 --dim $dim --seed 7 --quiet -o some.csv
    awk -F, -v dim=$dim 'NR == 1 { print; next }
        { printf "%.17g,%.17g", 1.2*$1 - 0.1, 1.2*$2 - 0.1; printf dim == 3 ? ",%.17g\n" : "\n", 1.2*$3 - 0.1 }' \
        some.csv > q.csv
    check "located in ${dim}D" "$pbw" locate m.csv q.csv -o l.csv
    check "located in ${dim}D: where" located $dim
    check "nearest in ${dim}D" "$pbw" nearest m.csv q.csv -k 5 -o n.csv
    check "nearest in ${dim}D: which" nearest $dim 5
    awk -F, 'NR == 1 { print $0 ",w"; next } { print $0 "," (NR % 7) * 1e-5 }' m.csv > w.csv
    "$pbw" locate w.csv q.csv --weights w -o l.csv > said 2>&1
    check "located in a regular triangulation" "$pbw" mesh w.csv --weights w --quiet -o m.ele
    check "located in a regular triangulation: where" located $dim
    cp w.csv m.csv
    check "nearest with weights" says 0 " 0 hidden" nearest w.csv q.csv --weights w -k 3 -o n.csv
    check "nearest with weights: which" nearest $dim 3 yes
done
printf '0,0\n1,1\n2,2\n' > line.csv
printf '2,1.9\n' > one.csv
check "points on one line have nearest ones" says 0 "3 found" nearest line.csv one.csv -k 9 -o n.csv
check "their order" lines '^0,[012],[210],' n.csv 3
check "points on one line have no simplices" says 1 "no simplices" locate line.csv one.csv
printf '0.5,0.5,0.5\n' > one3.csv
check "generated points, and queries" says 0 "1 inside, 0 outside" locate --generate uniform 2000 one3.csv
from_input() { "$pbw" locate m.csv - < one3.csv | grep '1 inside'; }
check "queries from standard input" from_input
printf '0.5,0.5\n' > one2.csv
check "queries in 2D of points in 3D" says 1 "one2.csv: queries in 2D, but points in 3D" locate m.csv one2.csv
check "queries in 3D of points in 2D" says 1 "queries in 3D, but points in 2D; --dim 2" locate line.csv m.csv

# Lattices of which each cell is a cube; the whole, walls or none.
awk 'BEGIN { for (i = 0; i < 64; i++) print i % 4 "," int(i / 4) % 4 "," int(i / 16) }' > lattice.csv
polyhedra() { sed -n '/"types"/,/<.DataArray/p' "$1" > types && lines '^42$' types "$2"; }
box=-0.5,-0.5,-0.5,3.5,3.5,3.5
whole="volume 64, the sum of cells; 64, the box; relative difference"
for more in "" "--periodic xyz" "--periodic y"; do
    # shellcheck disable=SC2086
    check "cubes $more" says 0 "$whole" cells lattice.csv --box $box --merge $more -o c.csv -o c.obj -o c.vtu
    check "cubes $more fill the box" awk '/relative difference/ { found = 1; far = $NF > 1e-15 }
        END { exit !found || far }' said
    check "cubes $more: volumes" every c.csv 2 1
    check "cubes $more: closed" enclosed
    check "cubes $more: facets" every c.csv 6 6
    check "cubes $more: quadrilaterals" lines '^f [0-9]* [0-9]* [0-9]* [0-9]*$' c.obj 384
    check "cubes $more: polyhedra" polyhedra c.vtu 64
done
"$pbw" cells lattice.csv --box $box --periodic xyz --merge --quiet -o c.csv -o c.obj
check "centroids" sh -c "sed 1d c.csv | cut -d, -f3-5 | awk -F, '{ printf \"%.12g,%.12g,%.12g\\n\", \$1, \$2, \$3 }' |
    sed 's/-0\\>/0/g' | cmp - lattice.csv"
printf 'x,y,z\n1,0,0\n-1,0,0\n0,1,0\n0,-1,0\n0,0,1\n0,0,-1\n' > six.csv
printf 'x,y,z\n1,1,1\n1,1,-1\n1,-1,1\n1,-1,-1\n-1,1,1\n-1,1,-1\n-1,-1,1\n-1,-1,-1\n' > eight.csv
by_gpu() {    # by_gpu POINTS OPTIONS: the cells of the CPU; or why there are none
    "$pbw" cells "$@" --quiet -o cpu.csv || return 1
    if "$pbw" cells "$@" --quiet --gpu -o gpu.csv > said 2>&1; then
        cmp cpu.csv gpu.csv
    else
        cat said
        grep -q "gpu: this program was built without CUDA; .make GPU=1 B=build/gpu. builds\|gpu: no usable device" said
    fi
}
check "cells by a GPU" by_gpu lattice.csv --box $box
even="--generate uniform 3000 --box 0,0,0,1,1,1"
# shellcheck disable=SC2086
check "cells in a periodic box by a GPU" by_gpu $even --periodic xyz
# shellcheck disable=SC2086
check "cells in a box periodic along one axis by a GPU" by_gpu $even --periodic x
check "no lattices by a GPU" says 2 "--gpu and --lattice 1,0,0,0,1,0,0,0,1 exclude" \
    cells lattice.csv --lattice 1,0,0,0,1,0,0,0,1 --gpu
check "pyramids of six cospherical points" says 0 "6 cells, 0 of them empty, 0 unbounded; 30 facets" \
    cells six.csv --box -1,-1,-1,1,1,1 --merge -o c.csv -o c.obj
check "pyramids are closed" enclosed
check "half of them" says 0 "6 cells, 3 of them empty, 0 unbounded; 15 facets" \
    cells six.csv --box 0,0,0,1,1,1 --merge -o c.csv
check "cells that touch the box" says 0 "8 cells, 7 of them empty, 0 unbounded; 6 facets" \
    cells eight.csv --box 0,0,0,2,2,2 --merge -o c.csv
printf 'x,y\n1,2\n6,4\n' > two.csv
printf 'x,y\n1,1\n3,2\n5,3\n9,5\n3,2\n' > line.csv
printf 'x,y,z,w\n1,1,2,0\n4,1,2,0\n1,5,2,0\n4,5,2,0\n2,3,2,-50\n' > level.csv
check "cells of two points" says 0 "area 48, the sum of cells; 48, the box" \
    cells two.csv --box 0,0,8,6 --merge -o c.csv -o c.svg -o c.vtu
check "their areas" [ "$(awk -F, 'NR > 1 { printf "%s ", $2 }' c.csv)" = "21 27 " ]
check "cells of points on a line" says 0 "5 cells, 1 of them empty, 0 unbounded; 16 facets" \
    cells line.csv --box 0,0,10,6 --merge -o c.csv
check "their areas" [ "$(awk -F, 'NR > 1 { printf "%s ", $2 }' c.csv)" = "7.5625 14.9375 22.5 15 0 " ]
printf '0,0\n10,0\n10,6\n0,6\n0,0\n' > frame.csv
check "in a polygon" says 0 "area 60, the sum of cells; 60, the polygon" cells line.csv --clip frame.csv -o d.csv
check "cells of points in a plane" says 0 "5 cells, 1 of them empty, 0 unbounded; 24 facets" \
    cells level.csv --weights w --box 0,0,0,5,6,4 --merge -o c.csv -o c.obj -o c.vtu -o c.html
check "their volumes" [ "$(awk -F, 'NR > 1 { printf "%s ", $2 }' c.csv)" = "30 30 30 30 0 " ]
check "cells of points in a plane are closed" enclosed
check "in the plane" says 0 "area 30, the sum of cells; 30, the box" cells level.csv --box 0,0,5,6 -o c.csv
check "two points without a box" says 1 "do not span the plane; with --box or --clip they have cells" cells two.csv
check "cells without a box" says 0 "64 cells, 0 of them empty, 56 unbounded" cells lattice.csv -o c.csv -o c.obj
check "pictures end at a box" says 0 "60 cells, 0 of them empty" cells --generate uniform 60 --dim 2 -o c.svg -o c.html
check "with the unbounded cells" lines 'id="cell_' c.svg 60
awk 'BEGIN { for (i = 0; i < 30; i++) print i * i "e100," i * 7 % 11 "e100," i * 5 % 13 "e100" }' > far.csv
check "cells out of range" says 0 "warning: points beyond 1e-57 to 1e60" cells far.csv
check "those inside" says 0 "volume 8, the sum of bounded cells" cells lattice.csv --merge
check "bounded ones are written" lines '^o' c.obj 8
printf '0.3,0.4,0.5\n' > point.csv
check "one point in a periodic box" says 0 "volume 6, the sum of cells; 6, the box" \
    cells point.csv --dim 3 --box 0,0,0,1,2,3 --periodic xyz --merge -o c.csv
check "its facets" every c.csv 6 6

# Irregular ones.
check "cells" says 0 "500 cells, 0 of them empty, 0 unbounded" \
    cells --generate uniform 500 --box 0,0,0,1,1,1 -o c.csv -o c.obj -o c.vtu
check "cells are closed" enclosed
check "cells without walls" "$pbw" cells --generate gauss 500 -o c.csv -o c.obj
check "cells without walls are closed" enclosed
check "periodic cells" "$pbw" cells --generate uniform 500 --box 0,0,0,1,1,1 --periodic xz -o c.csv -o c.obj
check "periodic cells are closed" enclosed
"$pbw" mesh --generate uniform 60 --dim 2 --quiet -o some.csv
awk -F, 'NR == 1 { print "x,y,w"; next }
    { print $0 ",0" } NR < 5 { print $1 + 1e-3 "," $2 ",-0.01" }' some.csv > heavy.csv
check "power cells" says 0 "3 of them empty, 0 unbounded" cells heavy.csv --weights w --box 0,0,1,1 -o c.svg -o c.csv
area() {    # loops of an .svg and their area, as a share of its square of 1000
    tr 'MZ">' '\n\n\n\n' < "$1" | awk -F'[ ,]' '/^ [0-9.e-]*,/ {
        n++
        for (i = 2; i < NF; i += 2) { k = i + 2 > NF ? 2 : i + 2; sum += $i * $(k + 1) - $(i + 1) * $k }
    } END { printf "%d %.4f\n", n, -sum / 2e6 }'
}
drawn() { area c.svg; [ "$(area c.svg)" = "$1" ]; }
check "a picture of power cells" drawn "60 1.0000"


# Cells clipped by a polygon: a triangle within a hole of a square, and a notch; in a picture holes are clockwise.
printf '%s\n' 0,0 1000,0 1000,1000 500,0 0,1000 0,0 600,100 900,100 900,400 600,100 > rings.csv
printf '0,0\n1,1\n0,0\n' > one.csv
printf '0,0\n1000,1000\n1000,0\n0,1000\n' > bow.csv
printf '{ "type": "Polygon", "coordinates": [[[0, 0], [1000, 0], [1000, 1000], [500, 0], [0, 1000], [0, 0]],%s' \
    ' [[600, 100], [900, 100], [900, 400], [600, 100]]] }' > rings.geojson
"$pbw" mesh --generate uniform 80 --dim 2 --quiet -o some.csv
awk -F, 'NR == 1 { print; next } { print 1000 * $1 "," 1000 * $2 }' some.csv > sites.csv
whole="area 455000, the sum of cells; 455000, the polygon"
check "clipped cells" says 0 "$whole" cells sites.csv --clip rings.csv -o c.svg -o c.csv -o c.html
check "clipped cells: a picture" [ "$(area c.svg | cut -d' ' -f2)" = 0.4550 ]
mv c.csv first.csv
check "clipped cells: rings as GeoJSON" says 0 "$whole" cells sites.csv --clip rings.geojson -o c.csv
check "clipped cells: which are the same" cmp c.csv first.csv
check "clipped cells: parts" "$pbw" cells sites.csv --clip rings.geojson --quiet -o c.obj -o c.vtu
flat() {    # the area of all faces of an .obj in the plane
    awk '$1 == "v" { n++; x[n] = $2; y[n] = $3 }
        $1 == "f" { for (i = 2; i <= NF; i++) { a = $i; b = i < NF ? $(i + 1) : $2; sum += x[a]*y[b] - y[a]*x[b] } }
        END { printf "%.4f\n", sum / 2 }' "$1"
}
check "clipped cells: the area of parts" [ "$(flat c.obj)" = 455000.0000 ]
check "a clipped cell with a hole" says 1 "has a hole, which .vtu cannot hold" \
    cells heavy.csv --clip rings.csv -o c.vtu
check "a ring of two corners" says 1 "the rings enclose nothing" cells sites.csv --clip one.csv -o c.csv
west='{"type": "MultiPolygon", "coordinates": [[[[0, 0], [5, 0], [5, 8], [0, 8], [0, 0]]]'
echo "$west, [[[5, 0], [12, 0], [12, 8], [5, 8], [5, 0]]]]}" > parcels.geojson
echo "$west, [[[5, 0], [12, 0], [12, 8], [5, 6], [5, 2], [5, 0]]], [[[12, 3], [12, 5], [14, 4], [12, 3]]]," \
    "[[[1, 1], [2, 2], [3, 3], [1, 1]]]]}" > parts.geojson
printf 'x,y\n3,7\n3.5,6\n10,3\n5,3\n1,4\n2,2\n7,5\n11,1\n5,5\n' > wells.csv
check "parcels that share an edge" says 0 "area 96, the sum of cells; 96, the polygon" \
    cells wells.csv --clip parcels.geojson -o c.csv -o c.vtu
"$pbw" cells wells.csv --box 0,0,12,8 --quiet -o d.csv
check "are as the box" awk -F, 'NR == FNR { v[$1] = $2; next } FNR > 1 && ($2 - v[$1]) ^ 2 > 1e-24 { bad = 1 }
    END { exit bad || NR != 2 * FNR }' c.csv d.csv
check "a part of an edge, and a flat ring" says 0 "area 91, the sum of cells; 91, the polygon" \
    cells wells.csv --clip parts.geojson -o c.csv -o c.svg
printf '0,0\n4,0\n8,0\n4,0\n4,4\n4,8\n4,4\n0,4\n0,0\n' > spikes.csv
check "spikes" says 0 "area 16, the sum of cells; 16, the polygon" cells wells.csv --clip spikes.csv -o c.csv
printf '0,0\n8,0\n8,8\n0,8\n0,0\n4,0\n6,4\n4,4\n4,0\n4,4\n4,6\n2,4\n4,4\n' > holes.csv
check "holes that touch" says 0 "area 58, the sum of cells; 58, the polygon" \
    cells wells.csv --clip holes.csv -o c.csv -o c.svg
printf '0,0\n4,0\n4,4\n0,0\n0,0\n4,0\n4,4\n0,0\n' > twice.csv
printf '0,0\n4,0\n4,4\n0,4\n0,0\n2,2\n6,3\n6,5\n2,2\n' > across.csv
check "rings that cross: where" says 1 \
    "the edge of ring 1 from (4, 0) and that of ring 2 from (2, 2) cross near (4, 2.5)" \
    cells wells.csv --clip across.csv
check "rings that cancel each other out" says 1 "the rings enclose nothing" cells wells.csv --clip twice.csv
check "rings that cross" says 1 "of ring 1 from" cells sites.csv --clip bow.csv -o c.csv

# Cells in a convex body: an octahedron, of which a box has no facet; a cube is a box.
printf '%s\n' OFF '6 8 12' '1 0 0' '-1 0 0' '0 1 0' '0 -1 0' '0 0 1' '0 0 -1' \
    '3 0 2 4' '3 2 1 4' '3 1 3 4' '3 3 0 4' '3 2 0 5' '3 1 2 5' '3 3 1 5' '3 0 3 5' > body.off
sed -e 's/^6 8/6 4/' -e 12,15d body.off > open.off
sed 's/^1 0 0/-0.1 0 0/' body.off > dent.off
awk 'BEGIN { for (i = 0; i < 8; i++) print "v", i % 2, int(i / 2) % 2, int(i / 4)
    print "f 1 2 4 3\nf 5 6 8 7\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6" }' > cube.obj
whole="volume 1.33333333333333, the sum of cells; 1.33333333333333, the body; relative difference "
check "cells in a body" says 0 "$whole" cells --generate gauss 500 --clip body.off -o c.csv -o c.obj -o c.vtu
check "cells in a body are closed" enclosed
check "a page of cells in a body" "$pbw" cells --generate gauss 500 --clip body.off --quiet -o c.html
"$pbw" cells --generate uniform 300 --box 0,0,0,1,1,1 --quiet -o c.csv
"$pbw" cells --generate uniform 300 --clip cube.obj --quiet -o d.csv
same() {    # volumes, centroids and counts of facets
    paste -d, c.csv d.csv | awk -F, 'NR > 1 { for (i = 2; i <= 6; i++) bad += ($i - $(i + 6)) ^ 2 > 1e-24 * $2 }
        END { exit NR != 301 || bad }'
}
check "cells in a cube are those in a box" same
check "a dent in a body" says 1 "dent.off: the surface is not convex" cells m.csv --clip dent.off -o c.csv
check "an open body" says 1 "open.off: the surface is not closed" cells m.csv --clip open.off -o c.csv
check "a body without triangles" says 1 "not a surface of triangles" cells m.csv --clip m.csv -o c.csv
check "rings in 3D" says 1 "2 coordinates where 3 are needed" cells m.csv --clip rings.csv -o c.csv

# Every allocation failing, one in each run, with QUICK every 17th: reading, cells, writing.  Then nothing is
# written, or what is right.  Allocations before main, as of CUDA's start in a build with a GPU, are not the program's.
cat > fails.c << 'END'
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdlib.h>
typedef int main_function(int, char **, char **);
typedef int start_function(main_function *, int, char **, void (*)(void), void (*)(void), void (*)(void), void *);
extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
static main_function *program;
static long left;
static int begin(int count, char **values, char **environment)
{
    left = getenv("FAIL_AT") != NULL ? atol(getenv("FAIL_AT")) : 0;
    return program(count, values, environment);
}
int __libc_start_main(main_function *main, int count, char **values, void (*init)(void), void (*fini)(void),
                      void (*end)(void), void *stack)
{
    start_function *start;
    *(void **)&start = dlsym(RTLD_NEXT, "__libc_start_main");
    program = main;
    return start(begin, count, values, init, fini, end, stack);
}
static int fails(void)
{
    if (left == 0 || --left > 0)
        return 0;
    errno = ENOMEM;
    return 1;
}
void *malloc(size_t n) { return fails() ? NULL : __libc_malloc(n); }
void *calloc(size_t n, size_t m) { return fails() ? NULL : __libc_calloc(n, m); }
void *realloc(void *p, size_t n) { return fails() ? NULL : __libc_realloc(p, n); }
END
printf '%s\n' 0,0 1,0 1,1 0.5,0 0,1 0,0 0.6,0.1 0.9,0.1 0.9,0.4 0.6,0.1 > ring.csv
awk 'NR < 7' heavy.csv > few.csv
failing() {    # failing NUMBER: the run in which that allocation fails
    rm -f c.csv c.svg c.html
    FAIL_AT=$1 LD_PRELOAD=./fails.so "$pbw" cells few.csv --clip ring.csv --threads 1 --quiet -o c.csv -o c.svg \
        -o c.html
}
all_failing() {
    k=1 last=0 hits=0 step=${QUICK:+17}
    while failing $k > said 2>&1; code=$?; [ $((k - last)) -lt 60 ]; do
        if [ $code != 0 ]; then
            hits=$((hits + 1)) last=$k
            if [ $code -gt 2 ] || ! grep -qE 'out of memory|Cannot allocate memory' said; then
                echo "allocation $k: status $code"
                cat said
                return 1
            fi
        fi
        for file in c.csv c.svg c.html; do
            [ ! -e $file ] || cmp $file right.$file || return 1
        done
        k=$((k + ${step:-1}))
    done
    [ $((hits * ${step:-1})) -gt 50 ] || { echo "only $hits allocations"; return 1; }
}
if ${CC:-cc} -shared -fPIC fails.c -o fails.so -ldl 2> /dev/null && failing 0 > /dev/null 2>&1; then
    mv c.csv right.c.csv
    mv c.svg right.c.svg
    mv c.html right.c.html
    check "clipped cells: every allocation failing" all_failing
else
    skip "clipped cells: every allocation failing (no malloc to replace)"
fi

# What VTK reads.
for python in "${PYTHON:-python3}" /usr/bin/python3 ""; do
    [ -z "$python" ] || "$python" -c "import vtk" > /dev/null 2>&1 && break
done
vtk() {     # vtk TYPE COUNT SIZE: the cells of c.vtu, and the sum of their sizes as VTK finds them
    "$python" - "$@" << 'END'
import sys, vtk
reader = vtk.vtkXMLUnstructuredGridReader()
reader.SetFileName("c.vtu")
reader.Update()
kind, count, size = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
sizes = vtk.vtkCellSizeFilter()
sizes.SetInputConnection(reader.GetOutputPort())
sizes.Update()
grid = sizes.GetOutput()
array = grid.GetCellData().GetArray("Volume" if kind == 42 else "Area")
found = sum(array.GetValue(i) for i in range(count))
print(grid.GetNumberOfCells(), grid.GetCellType(0), found)
sys.exit(grid.GetNumberOfCells() != count or grid.GetCellType(0) != kind or abs(found - size) > 1e-3 * size)
END
}
if [ -n "$python" ]; then
    "$pbw" cells --generate uniform 500 --box 0,0,0,1,1,1 --quiet -o c.vtu
    check "VTK reads polyhedra" vtk 42 500 1
    "$pbw" cells --generate uniform 500 --dim 2 --box 0,0,1,1 --quiet -o c.vtu
    check "VTK reads polygons" vtk 7 500 1
else
    skip "python3-vtk9: not installed"
fi

# Refused before the work.
check "no queries" early 2 "a file of queries is needed after that of points" locate lattice.csv
check "three inputs" early 2 "more than two inputs: b and c" nearest a b c
check "queries are no output" early 2 "it is an input" locate lattice.csv one3.csv --format csv -o one3.csv
check "one standard input" early 2 "points and queries cannot both be the standard input" locate - -
check "no neighbours" early 2 "-k 0: a whole number from 1 to 1000000" nearest a b -k 0
check "a box of no size" early 2 "--box 0,0,0,1,0,1: the low corner and the high corner are needed" \
    cells lattice.csv --box 0,0,0,1,0,1
"$pbw" mesh --generate uniform 400 --quiet -o repeated.csv
lattice_volumes() {     # the same cells by other vectors of the same lattice
    "$pbw" cells repeated.csv --box 0,0,0,1,1,1 --periodic xyz --quiet -o c.csv &&
        says 0 "volume 1, the sum of cells; 1, the box" cells repeated.csv --lattice 1,0,0,3,1,0,-2,4,1 -o c2.csv &&
        [ "$(cut -d , -f 1,6 c.csv)" = "$(cut -d , -f 1,6 c2.csv)" ]
}
check "cells of a lattice" lattice_volumes
check "cells of a lattice, 2D" says 0 "area 3.75, the sum of cells; 3.75, the box" \
    cells one2.csv --lattice 2,0.5,0.5,2 -o c.csv
check "a lattice without a number" early 2 "vectors are needed, 4 numbers in 2D or 9 in 3D" \
    cells repeated.csv --lattice 1,0,0,1,0
check "a lattice of the plane" says 1 "9 numbers are needed" cells repeated.csv --lattice 1,0,0,1
check "a flat lattice" says 1 "the vectors are flat" cells repeated.csv --lattice 1,0,0,2,0,0,0,0,1
check "a lattice and a box" early 2 "exclude each other" \
    cells repeated.csv --lattice 1,0,0,0,1,0,0,0,1 --box 0,0,0,1,1,1
check "periodic without a box" early 2 "--periodic xy: it needs --box" cells lattice.csv --periodic xy
check "axes" early 2 "--periodic xw: some of the letters x, y, z" cells lattice.csv --periodic xw
check "a box of the plane" says 1 "6 numbers are needed for points in 3D" cells lattice.csv --box 0,0,1,1
check "axes of the plane" says 1 "--periodic z: the points are in 2D" cells one2.csv --box 0,0,1,1 --periodic z
check "a picture of cells in 3D" says 1 ".svg of cells needs points in 2D" cells lattice.csv -o c.svg
finish
