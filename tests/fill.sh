#!/bin/sh
# fill.sh FOLDER: surfaces that FOLDER/pbw reads from .poly and .smesh and fills, beside TetGen, and what Gmsh,
# CalculiX and FreeFem++ say of the files, each where it is installed.
bin=$(cd "$1" && pwd)
pbw=$bin/pbw work=$bin/fills
. tests/check.sh
cd "$work" || exit 2

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

# Gmsh writes the groups again as .msh of version 2, of which the volumes and areas are as they must be.
"$pbw" fill whole.poly --size 1.5 --target 10 --quiet -o read.msh -o read.inp -o read.mesh
of_gmsh() {
    gmsh read.msh -0 -v 1 -format msh2 -o again.msh || return 1
    awk '/^\$Nodes/ { part = 1; next } /^\$Elements/ { part = 2; next } /^\$/ { part = 0 }
        part == 1 && NF == 4 { print > "again.node" }
        part == 2 && $2 == 4 { print $1, $(NF - 3), $(NF - 2), $(NF - 1), $NF, $4 > "again.ele" }
        part == 2 && $2 == 2 { print $1, $(NF - 2), $(NF - 1), $NF, $4 > "again.face" }' again.msh
    for ending in node ele face; do
        (echo head; cat again.$ending) > again && mv again again.$ending
    done
    volumes again && areas again && volumes again | cmp - volumes && areas again | cmp - areas
}
if has gmsh; then
    check "Gmsh reads regions and groups of facets" of_gmsh
else
    skip "gmsh: not installed"
fi

# FreeFem++: the integrals of 1 over each region and group of facets.
of_freefem() {
    {
        printf 'load "msh3"\nmesh3 Th = readmesh3("read.mesh"); cout.precision(8);\n'
        for region in 10 20; do
            printf 'cout << "volume %s " << int3d(Th, %s)(1.) << endl;\n' $region $region
        done
        for group in 1 2 3 4 5 6 9; do
            printf 'cout << "area %s " << int2d(Th, %s)(1.) << endl;\n' $group $group
        done
    } > read.edp
    FreeFem++ -nw -v 0 read.edp > freefem 2>&1
    cat freefem
    awk '{ printf "%s %.5f\n", $1, $2 }' volumes areas > due
    awk '/^volume|^area/ { printf "%s %.5f\n", $2, $3 }' freefem | cmp - due
}
export FF_LOADPATH=/usr/lib/freefem++
echo 'load "msh3"' > load.edp
if has FreeFem++ && FreeFem++ -nw -v 0 load.edp > /dev/null 2>&1; then
    check "FreeFem++ reads regions and groups of facets" of_freefem
else
    skip "freefem++: it or its module msh3 is not installed"
fi

# CalculiX: the pressure 1 on the facets of group 1, the bottom with its hole, is carried to the top as the force 23.
of_ccx() {
    {
        printf '*INCLUDE, INPUT=read.inp\n*MATERIAL, NAME=A\n*ELASTIC\n1000,0.3\n'
        printf '*MATERIAL, NAME=B\n*ELASTIC\n10,0.3\n'
        printf '*SOLID SECTION, ELSET=group_10, MATERIAL=A\n*SOLID SECTION, ELSET=group_20, MATERIAL=B\n'
        printf '*BOUNDARY\ngroup_2,1,3\n*STEP\n*STATIC\n*DSLOAD\ngroup_1,P,1\n'
        printf '*NODE PRINT, NSET=group_2, TOTALS=ONLY\nRF\n*END STEP\n'
    } > force.inp
    rm -f force.dat
    OMP_NUM_THREADS=1 ccx force
    awk 'NF == 3 && $1 + 0 == $1 { f = sqrt($1 * $1 + $2 * $2 + $3 * $3) }
         END { print f; exit !(f > 22.9999 && f < 23.0001) }' force.dat
}
if has ccx; then
    check "CalculiX reads regions and groups of facets" of_ccx
else
    skip "calculix-ccx: not installed"
fi
finish
