#!/bin/sh
# fill.sh FOLDER: surfaces that FOLDER/pbw reads from .poly and .smesh and fills, beside TetGen, and what Gmsh,
# CalculiX and FreeFem++ say of the files, each where it is installed.
bin=$(cd "$1" && pwd)
pbw=$bin/pbw work=$bin/fill
. tests/check.sh
cd "$work" || exit 2
has() { command -v "$1" > /dev/null; }
says() {    # says STATUS TEXT ARGUMENT...: the exit status, and a line of the output that has the text
    status=$1 text=$2
    shift 2
    "$pbw" "$@" < /dev/null > said 2>&1
    code=$?
    cat said
    [ $code = "$status" ] && grep -qF -- "$text" said
}

# Two regions with a wall between them, a tunnel through one, a cavity in the other; a line and a point in facets, a
# point inside.  The volumes are 48 - 1/6 and 44; facets 1 and 2 have 23, 3 has 48, 4 32, 5 16, 6 2.366, 9 16.
cat > parts.node << END
28 3 0 0
1 0 0 0
2 6 0 0
3 6 4 0
4 0 4 0
5 0 0 4
6 6 0 4
7 6 4 4
8 0 4 4
9 3 0 0
10 3 4 0
11 3 0 4
12 3 4 4
13 4 1 0
14 5 1 0
15 5 2 0
16 4 2 0
17 4 1 4
18 5 1 4
19 5 2 4
20 4 2 4
21 1 1 1
22 2 1 1
23 1 2 1
24 1 1 2
25 1 1 4
26 2 3 4
27 1 0 2
28 1.5 3 3
END
cat > facets << END
15 1
3 1 1
6 1 9 2 3 10 4
2 9 10
4 13 14 15 16
1 4.5 1.5 0
4 1 2
6 5 11 6 7 12 8
2 11 12
4 17 18 19 20
2 25 26
1 4.5 1.5 4
3 0 3
6 1 9 2 6 11 5
2 9 11
1 27
2 0 3
6 4 10 3 7 12 8
2 10 12
1 0 4
4 1 4 8 5
1 0 4
4 2 3 7 6
1 0 9
4 9 10 12 11
1 0 5
4 13 14 18 17
1 0 5
4 14 15 19 18
1 0 5
4 15 16 20 19
1 0 5
4 16 13 17 20
1 0 6
3 21 22 23
1 0 6
3 21 22 24
1 0 6
3 21 23 24
1 0 6
3 22 23 24
1
1 1.2 1.2 1.2
2
1 .5 .5 .5 10 .5
2 3.5 3.5 3.5 20 .1
END
(echo '0 3 0 0'; cat facets) > parts.poly
(cat parts.node facets) > whole.poly

# volumes NAME: of each region, in NAME.node and NAME.ele; areas NAME: of each marker, in NAME.node and NAME.face.
volumes() {
    awk 'FNR == 1 { file++; next } /^ *#/ { next }
        file == 1 { x[$1] = $2; y[$1] = $3; z[$1] = $4; next }
        { for (k = 2; k < 5; k++) {
              u[k] = x[$(k + 1)] - x[$2]; v[k] = y[$(k + 1)] - y[$2]; w[k] = z[$(k + 1)] - z[$2] }
          d = u[2] * (v[3] * w[4] - v[4] * w[3]) - u[3] * (v[2] * w[4] - v[4] * w[2])
          d += u[4] * (v[2] * w[3] - v[3] * w[2])
          volume[$6] += d < 0 ? -d / 6 : d / 6 }
        END { for (r in volume) printf "%s %.6f\n", r, volume[r] }' "$1.node" "$1.ele" | sort -n
}
areas() {
    awk 'FNR == 1 { file++; next } /^ *#/ { next }
        file == 1 { x[$1] = $2; y[$1] = $3; z[$1] = $4; next }
        $5 != 0 { for (k = 1; k < 3; k++) {
              u[k] = x[$(k + 2)] - x[$2]; v[k] = y[$(k + 2)] - y[$2]; w[k] = z[$(k + 2)] - z[$2] }
          d = (v[1] * w[2] - v[2] * w[1])^2 + (w[1] * u[2] - w[2] * u[1])^2 + (u[1] * v[2] - u[2] * v[1])^2
          area[$5] += sqrt(d) / 2 }
        END { for (r in area) printf "%s %.6f\n", r, area[r] }' "$1.node" "$1.face" | sort -n
}
printf '10 47.833333\n20 44.000000\n' > volumes
printf '1 23.000000\n2 23.000000\n3 48.000000\n4 32.000000\n5 16.000000\n6 2.366025\n9 16.000000\n' > areas
right() {   # right MODEL OPTION...: volumes and areas of the files
    rm -f out.*
    "$pbw" fill "$@" -o out.node -o out.ele -o out.face --quiet && volumes out && areas out &&
        volumes out | cmp - volumes && areas out | cmp - areas
}
check "a .poly file" right whole.poly
check "a .poly file with its .node file" right parts.poly
check "a .poly file, conforming" right whole.poly --conforming
check "the file says its regions" says 0 "region 20: " fill whole.poly
check "a line and a point in facets, a point inside" says 0 "28 points in 3D, 52 faces" fill whole.poly
check "pbw check reads facets" says 1 "0 pairs of faces that meet" check whole.poly
check "holes and regions that are not kept" says 0 "its holes and regions, 3 in all, are not kept" \
    convert whole.poly -o whole.off
check "facets in space are no plane" says 1 "pbw fill takes facets in space" plane whole.poly
check "the .node file beside is not overwritten" says 2 "parts.node" fill parts.poly -o parts.node
gzip -k whole.poly
check ".poly.gz" right whole.poly.gz
check "a .poly file, with its bounds of volumes" right whole.poly --volumes --target 10
cat > box.smesh << END
8 3
0 0 0 0
1 2 0 0
2 2 2 0
3 0 2 0
4 0 0 2
5 2 0 2
6 2 2 2
7 0 2 2
6 1
4 0 1 2 3 -7
4 4 5 6 7 8
4 0 1 5 4 8
4 1 2 6 5 8
4 2 3 7 6 8
4 3 0 4 7 8
0
END
check "a .smesh file" says 0 "12 facets on the surface" fill box.smesh -o box.msh2
check "markers of a .smesh file are groups" sh -c '[ "$(grep -c "^[0-9]* 2 2 8" box.msh2)" = 10 ]'

if has tetgen; then
    tetgen -pAQ whole.poly > tetgen.log 2>&1
    same() { volumes whole.1 && volumes whole.1 | cmp - volumes && areas whole.1 && areas whole.1 | cmp - areas; }
    check "TetGen has the same volumes and areas" same
else
    skip "tetgen: not installed"
fi
finish
