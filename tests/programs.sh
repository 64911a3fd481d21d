#!/bin/sh
# programs.sh FOLDER: what the programs that meshes are for say about the files that FOLDER/pbw writes: Gmsh, meshio,
# VTK, FreeFem++, CalculiX, each where it is installed.  The meshes are irregular ones of the unit square and cube.
bin=$1 work=$1/programs
. tests/check.sh
fails() { ! "$@"; }

points() {  # points DIM N: the points of a grid of N cells a side, those inside moved
    awk -v dim="$1" -v n="$2" '
        function move() { seed = seed * 16807 % 2147483647; return 0.4 * seed / 2147483647 - 0.2 }
        BEGIN { seed = 1
            for (i = 0; i <= n; i++) for (j = 0; j <= n; j++) for (k = 0; k <= (dim == 3 ? n : 0); k++) {
                inside = i % n && j % n && (dim == 2 || k % n)
                printf "%.15g,%.15g", (i + inside * move()) / n, (j + inside * move()) / n
                printf dim == 3 ? ",%.15g\n" : "\n", (k + inside * move()) / n } }'
}
surfaces="ply off obj stl" kinds="vtu msh msh2 mesh inp su2 node ele face $surfaces"
written() { # written NAME OPTION...: the mesh of the points in every format
    mesh=$1
    shift
    for kind in $kinds; do
        set -- "$@" -o "$mesh.$kind"
    done
    "$bin/pbw" mesh "$work/p.csv" --quiet "$@"
}
for dim in 2 3; do
    for n in 6 12 24 8; do
        points $dim $n > "$work/p.csv"
        check "meshes are written" written "$work/m$dim.$n"
    done
    check "meshes are written as text" written "$work/m$dim.text" --text
done

# Gmsh finds nothing to say, and as many points and elements as there are.  Of Medit it reads 3D only.
silent() { gmsh -check "$1" > "$work/gmsh" 2>&1 && ! grep -E '^(Error|Warning)' "$work/gmsh"; }
agrees() {
    read -r nodes rest < "$2.node"
    read -r cells rest < "$2.ele"
    read -r facets rest < "$2.face"
    silent "$1" && grep -E "Info +: $nodes (nodes|vertices)" "$work/gmsh" &&
        grep "Checking mesh coherence ($((cells + facets)) elements)" "$work/gmsh"
}
if has gmsh; then
    for file in m2.8.msh m3.8.msh m2.text.msh m3.text.msh m2.8.msh2 m3.8.msh2 m3.8.mesh m2.24.msh m3.24.msh; do
        check "gmsh -check $file" agrees "$work/$file" "$work/${file%.*}"
    done
    sed 's/^7 2 2 1 1 .*/7 2 2 1 1 1 1 2/' "$work/m3.8.msh2" > "$work/flat.msh2"
    check "gmsh -check finds a flat element" fails silent "$work/flat.msh2"
else
    skip "gmsh: not installed"
fi

# meshio and VTK read the files back, and tests/programs.py compares, in one run for each: it prints a line for a file
# that is right, and an error below the name of another.
tests=$(cd tests && pwd)
reads() { grep -qx "$2 is right" "$1" || { sed -n "/^$2: /,\$p" "$1"; return 1; }; }
for module in meshio vtk; do
    for python in "${PYTHON:-python3}" /usr/bin/python3 ""; do
        [ -z "$python" ] || ! "$python" -c "import numpy, $module" > /dev/null 2>&1 || break
    done
    if [ -n "$python" ]; then
        set --
        for file in m2.8 m3.8 m2.text m3.text; do
            for kind in $kinds; do
                case $module.$file.$kind in                          # what meshio cannot read; what has no other form
                *.face | meshio.m2.*.node | meshio.m2.*.ele) ;;
                *.vtu | meshio.*.8.* | meshio.*.text.msh | meshio.*.text.ply | meshio.*.text.stl)
                    set -- "$@" $file.$kind ;;
                esac
            done
        done
        (cd "$work" && "$python" "$tests/programs.py" $module "$@") > "$work/$module" 2>&1
        for file; do
            check "$module reads $file" reads "$work/$module" $file
        done
    else
        skip "python3-$module: not installed"
    fi
done

# Regions, patches and sharp edges as groups: a cube in a cube.  Gmsh writes as many elements of each group again;
# CalculiX carries the pressure on one patch to the patch across, through both regions.
{
    for box in "0 1 0" "0.3 0.7 8"; do
        echo "$box" | awk '{ for (i = 0; i < 8; i++) print "v", $(1 + i % 2), $(1 + int(i / 2) % 2), $(1 + int(i / 4))
            n = split("1 3 4 2 5 6 8 7 1 2 6 5 3 7 8 4 1 5 7 3 2 4 8 6", c, " ")
            for (i = 1; i < n; i += 4) print "f", c[i] + $3, c[i + 1] + $3, c[i + 2] + $3, c[i + 3] + $3 }'
    done
} | sort -s -k1,1r > "$work/nest.obj"
groups() { "$bin/pbw" solid "$work/nest.obj" --nested --patches --size 0.3 "$@" --quiet; }
check "groups are written" groups -o "$work/nest.msh" -o "$work/nest.inp" -o "$work/nest.vtu"
again() {
    gmsh "$work/nest.msh" -0 -v 1 -format msh2 -o "$work/again.msh" &&
        awk '/^\$Elements/ { on = 1; next } on && NF > 4 { n[$2 " " $4]++ } END { for (k in n) print k }' \
            "$work/again.msh" > "$work/again" && [ "$(wc -l < "$work/again")" = 15 ]
}
force() {
    {
        printf '*INCLUDE, INPUT=nest.inp\n*MATERIAL, NAME=A\n*ELASTIC\n1000,0.3\n'
        printf '*MATERIAL, NAME=B\n*ELASTIC\n10,0.3\n'
        printf '*SOLID SECTION, ELSET=region_0, MATERIAL=A\n*SOLID SECTION, ELSET=region_1, MATERIAL=B\n'
        printf '*BOUNDARY\npatch_0,1,3\n*STEP\n*STATIC\n*DSLOAD\npatch_1,P,1\n'
        printf '*NODE PRINT, NSET=patch_0, TOTALS=ONLY\nRF\n*END STEP\n'
    } > "$work/force.inp"
    (cd "$work" && rm -f force.dat && OMP_NUM_THREADS=1 ccx force)
    awk 'NF == 3 && $1 + 0 == $1 { f = sqrt($1 * $1 + $2 * $2 + $3 * $3) }
         END { print f; exit !(f > 0.999999 && f < 1.000001) }' "$work/force.dat"
}
if has gmsh; then
    check "gmsh -check nest.msh" silent "$work/nest.msh"
    check "gmsh keeps the groups" again
fi
! has ccx || check "CalculiX knows the groups" force
for python in "${PYTHON:-python3}" /usr/bin/python3; do
    "$python" -c "import numpy, meshio" > /dev/null 2>&1 || continue
    check "meshio reads the groups" "$python" tests/programs.py groups "$work/nest"
    break
done

# What VTK and Gmsh say of the quality of a mesh, element by element, is what pbw improve says.
"$bin/pbw" mesh --generate uniform 2000 -o "$work/raw.msh" --quiet
"$bin/pbw" improve "$work/raw.msh" --smooth odt --only-smooth --quality -o "$work/smooth.vtu" -o "$work/smooth.msh" \
    > "$work/quality"
for python in "${PYTHON:-python3}" /usr/bin/python3; do
    "$python" -c "import numpy, vtk" > /dev/null 2>&1 || continue
    check "measures of quality are Verdict's" "$python" tests/quality.py "$work/quality" "$work/smooth.vtu"
    break
done
if has gmsh && "$python" -c "import numpy" > /dev/null 2>&1; then
    set -- -setnumber Print.PostElementary 0 -setnumber Print.PostElement 0 -setnumber Print.PostGamma 1
    gmsh "$work/smooth.msh" -0 -v 1 "$@" -setnumber Print.PostSICN 1 -setnumber Print.PostSIGE 0 -format pos \
        -o "$work/smooth.pos"
    check "SICN and gamma are Gmsh's" "$python" tests/quality.py "$work/quality" "$work/smooth.pos"
fi

# FreeFem++: -Laplace u = f with u = product of sin(pi x), from 6 to 12 to 24 cells a side: the error falls with the
# square of the size.  The groups have the right size, and the facets look outward: div(x) = dim.
poisson() {  # poisson DIM
    if [ "$1" = 2 ]; then
        kind=mesh read=readmesh inner=int2d outer=int1d surface=4 factor=1 z=
    else
        kind=mesh3 read=readmesh3 inner=int3d outer=int2d surface=6 factor="sin(pi*z)" z="+dz(u)*dz(v)"
    fi
    {
        [ "$1" = 2 ] || echo 'load "msh3"'
        echo "func exact = sin(pi*x)*sin(pi*y)*$factor; real[int] e(3);"
        for n in 6 12 24; do
            step=$((n / 12))
            cat << END
{ $kind Th = $read("$work/m$1.$n.mesh"); fespace Vh(Th, P1); Vh u, v;
solve P(u, v, solver=sparsesolver) = $inner(Th)(dx(u)*dx(v)+dy(u)*dy(v)$z)
    - $inner(Th)($1*pi^2*exact*v) + on(1, u=0);
e[$step] = sqrt($inner(Th)((u-exact)^2));
cout << "group " << $inner(Th, 2)(1.)-1 << " " << $outer(Th, 1)(1.)-$surface << " "
    << $outer(Th, 1)(N.x*x+N.y*y$([ "$1" = 2 ] || echo "+N.z*z"))-$1 << endl; }
END
        done
        echo 'cout << "order " << log(e[0]/e[1])/log(2.) << " " << log(e[1]/e[2])/log(2.) << endl;'
    } > "$work/poisson$1.edp"
    FreeFem++ -nw -v 0 "$work/poisson$1.edp" > "$work/freefem" 2>&1
    tail -n 5 "$work/freefem"
    awk 'function small(x) { return x < 1e-9 && x > -1e-9 }
         $1 == "group" { groups += small($2) && small($3) && small($4) }
         $1 == "order" { orders += $2 > 1.8 && $2 < 2.3 && $3 > 1.8 && $3 < 2.3 }
         END { exit !(groups == 3 && orders == 1) }' "$work/freefem"
}
# FreeFem++ and pbw improve in turn: -Laplace u = 0 in a prism over an L, u = r^(2/3) sin(2/3 phi), which is
# singular at an edge: the error in the H1 seminorm falls with the power -1/3 of the count, as for smooth solutions;
# with equal sizes it would be -2/9.
adapt() {
    awk 'BEGIN { n = split("-1 -1 0 -1 0 0 1 0 1 1 -1 1", p, " ") / 2
        for (z = 0; z <= 1; z++) for (i = 0; i < n; i++) print "v", p[2 * i + 1], p[2 * i + 2], z
        print "f 3 2 1\nf 1 6 3\nf 3 6 5\nf 5 4 3\nf 7 8 9\nf 9 12 7\nf 9 11 12\nf 9 10 11"
        for (i = 1; i <= n; i++) { k = i % n + 1; print "f", i, k, k + n; print "f", i, k + n, i + n } }' \
        > "$work/l.obj"
    cat > "$work/adapt.edp" << END
load "msh3"
mesh3 Th = readmesh3("$work/l.mesh"); fespace Vh(Th, P1); fespace Ph(Th, P0);
func real phi() { return atan2(y, x) + (y < 0 ? 2*pi : 0); }
func r = sqrt(x*x + y*y) + 1e-99;
func exact = r^(2./3)*sin(2./3*phi());
func gx = -2./3*r^(-1./3)*sin(phi()/3);
func gy = 2./3*r^(-1./3)*cos(phi()/3);
Vh u, v;
solve P(u, v, solver=CG, eps=1e-8) = int3d(Th)(dx(u)*dx(v)+dy(u)*dy(v)+dz(u)*dz(v)) + on(1, u=exact);
varf e(unused, w) = int3d(Th, qfV=qfV5)(w*((dx(u)-gx)^2+(dy(u)-gy)^2+dz(u)^2));
real[int] s = e(0, Ph);
{ ofstream file("$work/errors"); for (int i = 0; i < Th.nt; i++) file << sqrt(s[i]) << endl; }
cout << "error " << Th.nt << " " << sqrt(s.sum) << endl;
END
    "$bin/pbw" solid "$work/l.obj" --size 0.35 -o "$work/l.mesh" --quiet || return 1
    for count in 2500 6000 14000; do
        FreeFem++ -nw -v 0 "$work/adapt.edp" | grep error
        "$bin/pbw" improve "$work/l.mesh" --error "$work/errors" --count $count -o "$work/next.mesh" --quiet ||
            return 1
        mv "$work/next.mesh" "$work/l.mesh"
    done > "$work/adapted"
    FreeFem++ -nw -v 0 "$work/adapt.edp" | grep error >> "$work/adapted"
    cat "$work/adapted"
    awk '{ n[NR] = $2; e[NR] = $3 }
         END { slope = log(e[NR] / e[1]) / log(n[NR] / n[1]); print "order", slope
             exit !(NR == 4 && slope < -0.28) }' "$work/adapted"
}
export FF_LOADPATH=/usr/lib/freefem++
if has FreeFem++; then
    check "FreeFem++ solves a Poisson problem in 2D" poisson 2
    echo 'load "msh3"' > "$work/load.edp"
    if FreeFem++ -nw -v 0 "$work/load.edp" > /dev/null 2>&1; then
        check "FreeFem++ solves a Poisson problem in 3D" poisson 3
        check "FreeFem++ and pbw improve adapt tetrahedra to a singular edge" adapt
    else
        skip "freefem++ in 3D: its module msh3 is not installed (libfreefem++)"
    fi
else
    skip "freefem++: not installed"
fi

# The thin-walled parts of CGAL's demo data, where a size of 1.8 % of the diagonal is near the thickness of walls.
data=/usr/share/doc/libcgal-dev/data.tar.gz
thin() {    # thin NAME SIZE
    tar xzf $data -C "$work" "data/meshes/$1.off" &&
        "$bin/pbw" solid "$work/data/meshes/$1.off" --size "$2" -o "$work/thin.vtu" > "$work/thin" 2>&1
    cat "$work/thin"
    awk '/^after:/ { good = $4 + 0 >= 24 && $5 >= 28 && $12 <= 155 }
         /warning/ { warnings++ }
         /^Euler number/ { whole = $3 + 0 == $7 + 0 && / no manifold 0, points 0/ }
         /^Hausdorff/ { near = $3 <= 0.15 }
         END { exit !(good && whole && near && !warnings) }' "$work/thin"
}
if [ -f $data ]; then
    check "pbw solid fills the anchor" thin anchor 0.02624
    check "pbw solid fills the drag knob" thin dragknob 0.02667
else
    skip "thin walls: CGAL's data are not installed (libcgal-demo)"
fi

# CalculiX: linear displacements come out exactly: first held on the boundary, then under pressure, held just so that
# the body cannot move.  It prints 7 digits, so nodes that are tied to the difference from what is due are printed.
patch() {   # patch DIM LOAD
    awk -v dim="$1" -v load="$2" '
        function due(k) {
            if (load == "pressure") return (dim == 3 ? -0.4 : -0.7) * x[k]
            if (k == 1) return 0.3 * x[1] - 0.1 * x[2] + 0.2 * x[3]
            return k == 2 ? 0.15 * x[1] + 0.25 * x[2] - 0.05 * x[3] : 0.1 * x[1] + 0.2 * x[2] - 0.3 * x[3] }
        BEGIN { FS = "," }
        /^\*/ { part = $1 $2; next }
        part ~ /NODE/ { at[$1] = $2 "," $3 "," $4; count = $1 }
        part == "*NSET NSET=BOUNDARY" { edge[$1] = 1 }
        END {
            for (i = 1; i <= count; i++) {
                split(at[i], x, ",")
                origin = x[1] + x[2] + x[3] == 0
                corner = origin ? 3 : x[1] == 1 && x[2] + x[3] == 0 ? 2 : x[2] == 1 && x[1] + x[3] == 0
                for (k = 1; k <= dim; k++)
                    if (load == "held" ? edge[i] : corner == 3 || (corner == 2 && k > 1) || (corner == 1 && k > 2))
                        held = held sprintf("%d,%d,%d,%.16f\n", i, k, k, due(k))
                if (edge[i] && load == "held") continue
                nodes = nodes sprintf("%d,0.5,0.5,0\n", ++extra + count + 1)
                for (k = 1; k <= dim; k++)
                    ties = ties sprintf("3\n%d,%d,1,%d,%d,-1,%d,1,%.16f\n", extra + count + 1, k, i, k, count + 1,
                                        due(k))
            }
            printf "*NODE\n%d,0,0,0\n*NODE, NSET=FAULTS\n%s*EQUATION\n%s", count + 1, nodes, ties
            printf "*BOUNDARY\n%d,1,1,1\n%s", count + 1, held
        }' "$work/m$1.8.inp" > "$work/ties.inp"
    {
        echo "*INCLUDE, INPUT=m$1.8.inp"
        printf '*MATERIAL, NAME=M\n*ELASTIC\n1000,0.3\n*SOLID SECTION, ELSET=DOMAIN, MATERIAL=M\n'
        [ "$1" = 3 ] || echo 1
        echo "*INCLUDE, INPUT=ties.inp"
        printf '*STEP\n*STATIC\n'
        [ "$2" = held ] || printf '*DSLOAD\nBOUNDARY,P,1000\n'
        printf '*NODE PRINT, NSET=FAULTS\nU\n*END STEP\n'
    } > "$work/patch.inp"
    rm -f "$work/patch.dat"
    (cd "$work" && OMP_NUM_THREADS=1 ccx patch)
    awk 'NF == 4 && $1 + 0 > 0 { rows++; for (k = 2; k <= 4; k++) if ($k * $k > worst * worst) worst = $k }
         END { print rows + 0, "nodes, worst", worst; exit !(rows >= 49 && worst * worst < 1e-18) }' "$work/patch.dat"
}
if has ccx; then
    check "CalculiX in 3D, held" patch 3 held
    check "CalculiX in 3D, under pressure" patch 3 pressure
    check "CalculiX in 2D, held" patch 2 held
    check "CalculiX in 2D, under pressure" patch 2 pressure
else
    skip "calculix-ccx: not installed"
fi
finish
