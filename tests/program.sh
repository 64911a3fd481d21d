#!/bin/sh
# program.sh FOLDER: the command line of FOLDER/pbw: what it refuses and with which words, what it leaves whole, which
# files it reads.  Every check is of an exit status and of what is printed or written.
bin=$(cd "$1" && pwd) root=$PWD
pbw=$bin/pbw work=$bin/program
. tests/check.sh
cd "$work" || exit 2

same_mesh() {   # same_mesh FILE FILE [OPTION...]: the same triangulation
    a=$1 b=$2
    shift 2
    "$pbw" mesh "$a" > one && "$pbw" mesh "$b" "$@" > two && grep -o 'hash.*' one > hash && grep -F "$(cat hash)" two
}
silent() { "$pbw" "$@" > said 2>&1 && ! [ -s said ]; }
kept() { cmp "$1" "$1.old"; }

printf 'name,x,y,z,r\nC,0,0,0,1\nN,1,0,0,1\nO,0,1,0,1\nH,0,0,1,1\nH,1,1,1.5,2\n' > atoms.csv
cp atoms.csv atoms.csv.old
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n' > open.obj
(cat open.obj; echo 'f 1 4 3') > closed.obj
(cat closed.obj; printf 'f 1 4 3\nv 5 5 5\nv 6 5 5\nv 5 6 5\nf 5 6 7\n') > crowded.obj
"$pbw" mesh --generate uniform 500 --quiet -o m.csv -o m.vtu -o m.msh -o m.msh2 -o m.mesh -o m.node -o m.ele
"$pbw" mesh --generate uniform 500 --quiet --text -o t.vtu
"$pbw" mesh --generate uniform 500 --quiet --dim 2 -o p.csv -o p.vtu -o p.msh -o p.mesh -o p.node -o p.ele

# Outputs are packed where their names end in .gz; what a file has and is not kept has a word.
"$pbw" mesh --generate uniform 500 --quiet -o p.vtu.gz -o p.csv.gz -o p.svg.gz -o p.html.gz
for packed in p.vtu.gz p.csv.gz p.svg.gz p.html.gz; do
    check "$packed is packed" gzip -t $packed
done
check "p.csv.gz unpacked is m.csv" sh -c 'gzip -dc p.csv.gz | cmp - m.csv'
check "p.vtu.gz is read" same_mesh p.vtu.gz m.csv
check "no packed file of tiles" says 2 "-o t.pbwt.gz: " tiles m.csv -o t.pbwt.gz
printf 'OFF\n4 1 0\n0 0 0\n4 4 0\n4 0 0\n0 4 1\n4 0 1 2 3\n' > bow.off
check "an outline that crosses itself" says 0 "warning: bow.off: not kept: outlines of 1 polygon" mesh bow.off
check "the same as a surface" says 1 "warning: bow.off: not kept: outlines of 1 polygon" mesh m.csv --inside --surface bow.off
check "the same as queries" says 0 "warning: bow.off: not kept: outlines of 1 polygon" locate m.csv bow.off
printf '0 0\n1 0\n0 1\n' > points.dxf
check "an ending that is not read" says 1 "points.dxf: files with this ending are not read: export its surface as .stl or .obj; formats that are read: .obj" \
    mesh points.dxf
printf '<?xml version="1.0"?>\n<VTKFile type="PolyData"/>\n' > poly.vtp
printf '\223NUMPY\001\000' > array.npy
check "arrays of NumPy" says 1 "array.npy: files with this ending are not read: save its points as" mesh array.npy
printf '(1 "a mesh of Fluent")\n(2 3)\n' > fluent.msh
check ".msh of others" says 1 "fluent.msh:1: the first line is not \"\$MeshFormat\": .msh files of Gmsh are read" check fluent.msh
check ".vtp" says 1 "poly.vtp: files with this ending are not read: save it as .vtu, .vtk or .ply; formats" plane poly.vtp

# Tables: which columns are the coordinates, and which are kept.
printf 'id,easting,northing,height\n1,0,0,5\n2,4,0,6\n3,0,4,7\n4,1,1,9\n' > stations.csv
check "names that are known" says 0 "columns: x = column 2 (easting), y = column 3 (northing), z = column 4 (height)" \
    mesh stations.csv
check "columns are kept" says 0 "3 triangles" mesh stations.csv --dim 2 --keep id -o kept.csv
check "with their names" sh -c 'head -n 1 kept.csv | grep -q "^x,y.*,id"'
printf 'lon,lat,easting,northing\n0,0,5,5\n1,0,6,5\n0,1,5,6\n' > two.csv
check "two pairs of names" says 1 "two.csv:1: several columns may be x and y: lon (1), lat (2), easting (3)" mesh two.csv

# An input is never an output, by whichever name.
ln -s atoms.csv link.csv
ln atoms.csv hard.csv
for output in atoms.csv ./atoms.csv link.csv hard.csv; do
    check "the input is no output: $output" says 2 "-o $output: it is an input" mesh atoms.csv --weights r -o $output
done
check "the input is kept" kept atoms.csv
from_input() { ! "$pbw" mesh - -o atoms.csv < atoms.csv > said 2>&1 && grep 'it is an input' said; }
check "standard input is no output" from_input
check "the surface is no output" says 2 "it is an input" mesh atoms.csv --inside --surface closed.obj -o closed.obj
check "the points of an .ele file are no output" says 2 "it is an input" mesh m.ele -o m.node
check "an output twice" says 2 "it is named twice" mesh atoms.csv -o a.obj -o a.obj

# Links stay, modes too; FIFOs are written to; what may not be written is not replaced.
echo old > target.obj
chmod 640 target.obj
mkdir folder
ln -s ../target.obj folder/link.obj
ln -s later.obj dangling.obj
check "a link is written through" silent mesh atoms.csv --quiet -o folder/link.obj -o dangling.obj
check "a link stays" sh -c "[ -h folder/link.obj ] && [ -h dangling.obj ]"
check "what it leads to is written" sh -c "grep '^f' target.obj && grep '^f' later.obj && ! ls target.obj.part*"
closed() {  # closed STREAMS...: a report goes nowhere, not into an output
    "$pbw" mesh atoms.csv --weights r --quiet -o shown.obj || return 1
    rm -f shut.obj
    case $1 in
        all) "$pbw" mesh atoms.csv --weights r -o shut.obj <&- >&- 2>&- ;;
        in) "$pbw" mesh atoms.csv --weights r -o shut.obj <&- > said ;;
        out) "$pbw" mesh atoms.csv --weights r -o shut.obj >&- 2> said ;;
        both) "$pbw" mesh atoms.csv --weights r -o shut.obj >&- 2>&- ;;
        none) ! "$pbw" mesh no.csv -o shut.obj <&- >&- 2>&- && ! [ -e shut.obj ] && cp shown.obj shut.obj ;;
    esac
    cmp shown.obj shut.obj
}
for streams in all in out both none; do
    check "standard streams that are closed: $streams" closed $streams
done
closed_output() { ! "$pbw" mesh atoms.csv --weights r --format obj -o - 2> said >&- && grep 'standard output: ' said; }
check "an output to a closed stream is a failure" closed_output
closed_input() { ! "$pbw" mesh - -o shut.obj 2> said <&- && grep 'pbw: ' said; }
check "points of a closed stream are a failure" closed_input
echo mine > kept.part
ln -s atoms.csv kept2.obj.part
ln -s kept.part kept3.obj.part
check "files named .part are no business of an output" sh -c "'$pbw' mesh atoms.csv --quiet -o kept -o kept2.obj \
    -o kept3.obj --format obj && grep mine kept.part && cmp atoms.csv atoms.csv.old && [ -h kept3.obj.part ]"
check "an input named .part of an output is read" sh -c "cp atoms.csv p.obj.part &&
    '$pbw' mesh p.obj.part --quiet -o p.obj && cmp p.obj.part atoms.csv && grep '^f' p.obj"
two_runs() {    # 2 runs on one output, many times: it is always one of the two
    for try in 1 2 3 4 5 6; do
        "$pbw" mesh --generate uniform 2000 --seed 1 --quiet -o two.obj & one=$!
        "$pbw" mesh --generate uniform 2000 --seed 2 --quiet -o two.obj && wait $one || return 1
        cmp -s two.obj seed1.obj || cmp two.obj seed2.obj || return 1
    done
    ! ls two.obj.part*
}
"$pbw" mesh --generate uniform 2000 --seed 1 --quiet -o seed1.obj
"$pbw" mesh --generate uniform 2000 --seed 2 --quiet -o seed2.obj
check "two runs on one output" two_runs
check "a mode stays" sh -c "ls -l target.obj | grep '^-rw-r-----'"
mkfifo fifo
fifo() {
    cat fifo > got &
    "$pbw" mesh atoms.csv --quiet --format obj -o fifo && wait $! && [ -p fifo ] && grep '^f' got
}
check "a FIFO is written to" fifo
output() { "$pbw" mesh atoms.csv -o - --format csv 2> report | grep -c '[0-9],' | grep 5 && grep valid report; }
check "-o -" output
full() { ! "$pbw" "$@" > /dev/full 2> said && grep 'standard output: No space left' said; }
if [ -w /dev/full ]; then
    check "a report on a full disk is a failure" full mesh atoms.csv
    check "help on a full disk is a failure" full --help
    told() { ! "$pbw" mesh atoms.csv --quiet --format obj -o - 2> said > /dev/full && [ "$(wc -l < said)" = 1 ]; }
    check "an output to a full disk is told once" told
    check "an output on a full disk is a failure" says 1 "/dev/full: No space left" mesh atoms.csv --format obj \
        -o /dev/full
else
    skip "full disks: there is no /dev/full"
fi

# Refused before the work: nothing is read or reported.
early() { says "$@" && [ "$(wc -l < said)" = 1 ]; }

# The page that pbw view names replaces pages only.
echo notes > atoms.html
cp atoms.html atoms.html.old
check "view replaces no file by itself" early 2 "atoms.html is there already, and is no page of pbw" view atoms.csv
check "the file is kept" kept atoms.html
check "view replaces it on request" silent view atoms.csv --quiet -o atoms.html
check "it is a page" grep '<title>atoms.csv</title>' atoms.html
check "view replaces its own page" silent view atoms.csv --quiet --title again
check "it is another page" grep '<title>again</title>' atoms.html
rm atoms.html
check "view makes a page" says 0 "open this in a browser: atoms.html" view atoms.csv
mkdir m.html
check "view and a folder of that name" early 2 "-o m.html: it is a folder" view m.csv
check "a missing folder" early 2 "there is no folder no/" mesh atoms.csv -o no/a.obj
check "a folder" early 2 "it is a folder" mesh atoms.csv --format obj -o folder
check "a folder, by its name alone" early 2 "-o folder: it is a folder" mesh atoms.csv -o folder
check "an unknown ending" early 2 "-o a.docx: its ending tells the format" mesh atoms.csv -o a.docx
check "the endings are named" early 2 "pbw sample writes ply obj off xyz csv" sample open.obj -o a.vtu
check "-o - without a format" early 2 "else --format" mesh atoms.csv -o -
check "an unknown format" early 2 "--format docx: pbw mesh writes vtu" mesh atoms.csv --format docx -o -
check "a missing surface" early 2 "--surface no.obj: No such file" mesh atoms.csv --inside --surface no.obj
check "--surface alone" early 2 "it needs --inside" mesh atoms.csv --surface open.obj
check "--inside of generated points" early 2 "has no faces" mesh --generate uniform 9 --inside
unbuilt() { says "$@" && ! grep build said; }
check "--inside without faces" unbuilt 1 "atoms.csv has none" mesh atoms.csv --inside
check "a surface without faces" unbuilt 1 "atoms.csv has none" mesh m.csv --inside --surface atoms.csv

# Wrong usage names the option, the value and what is allowed.
check "--threads" early 2 "--threads 1000: a whole number from 0 to 256 is needed" mesh atoms.csv --threads 1000
check "--threads, no number" early 2 "--threads x: a whole" mesh atoms.csv --threads x
check "--dim" early 2 "--dim 4: a whole number from 2 to 3 is needed" mesh atoms.csv --dim 4
check "--generate" early 2 "one of uniform, gauss, ball, sphere, lattice" mesh --generate bogus 9
check "--generate, nearly" early 2 "the nearest is sphere" mesh --generate shpere 9
check "--generate without a count" early 2 "--generate sphere: a count from 1 to 4000000000" mesh --generate sphere
check "--generate and an input" early 2 "exclude each other" mesh --generate sphere 9 atoms.csv
check "--colour" early 2 "--colour bogus: one of quality, region, patch, part" mesh atoms.csv --colour bogus -o a.html
check "--colour weight" early 2 "it needs --weights" mesh atoms.csv --colour weight -o a.html
check "--eye" early 2 "--eye 0,0,0: a direction X,Y,Z other than 0,0,0" mesh atoms.csv --eye 0,0,0
check "--cut" early 2 "D from -1 to 1" mesh atoms.csv --cut 1,0,0,2
check "--memory-limit" early 2 "--memory-limit much: a number of bytes" mesh atoms.csv --memory-limit much
check "a missing value" early 2 "--dim: a whole number" mesh atoms.csv --dim
check "a misspelt option" early 2 "the nearest is --threads" mesh atoms.csv --thraeds 3
check "an option of another command" early 2 "pbw check has no option --eye, pbw mesh has" check open.obj --eye 1,2,3
check "a misspelt command" early 2 "the nearest command is check" chekc open.obj
check "no command at all" early 2 "pbw help lists the commands" xyzzy
check "pbw help" says 0 "pbw convert  --help" help
check "pbw help COMMAND" says 0 "usage: pbw sample" help sample
check "a file that starts with -" says 1 "-a.xyz: No such file" mesh -- -a.xyz
check "out of memory" says 1 "out of memory within --memory-limit 1M: 50000 points in 3D need about 16 MB" \
    mesh --generate uniform 50000 --memory-limit 1M

# Surfaces: where their faults are.
check "an open surface" says 1 "no volume: 3 open, 0 crowded, 0 turned edges in 1 loop" check open.obj
check "its edges" grep -F "3 edges from (0, 0, 0): 0-2 0-3 2-3" said
check "its components" grep -F "with point 0: 3 faces, 3 open, 0 crowded, 0 turned edges" said
check "a closed surface" says 0 "volume 0.166667" check closed.obj
check "a crowded surface" says 1 "2 components" check crowded.obj
check "its crowded edges" grep -F "0-3: faces 1 3 4" said
check "its loop" grep -F "3 edges from (5, 5, 5): 4-5 4-6 5-6" said
(sed 's/f 1 2 4/f 1 4 2/' closed.obj) > turned.obj
check "a turned surface" says 1 "3 turned edges:" check turned.obj

# Faces that meet, without area, and given again: two tetrahedra, a corner of one in the other.
printf 'v %s\n' '0 0 0' '4 0 0' '0 4 0' '0 0 4' '1 1 1' '5 1 1' '1 5 1' '1 1 5' > meet.obj
printf 'f %s\n' '1 3 2' '1 2 4' '2 3 4' '1 4 3' '5 7 6' '5 6 8' '6 7 8' '5 8 7' >> meet.obj
faults="-o faults.vtu -o faults.obj -o faults.csv -o faults.html"
check "faces that meet" says 1 "3 pairs of faces meet elsewhere than in corners and edges of both" check meet.obj $faults
check "which, and where" grep -E "^  2 and 4 from \((1, 2|2, 1), 1\) to \((1, 2|2, 1), 1\)$" said
check "the surface is closed" grep -F "closed, 2 components" said
check "a table of them" sh -c "grep -c '^crossing,2,[457],,,[12],[12],[12],[12],[12],[12]$' faults.csv | grep -x 3"
check "the model in groups" sh -c "grep -x 'g crossing' faults.obj && grep -x 'g sound' faults.obj &&
    grep -x 'g crossing line' faults.obj && grep -c '^l ' faults.obj | grep -x 3"
check "it is read again" says 1 "3 pairs of faces meet" check faults.obj
check "the same as .vtu" says 1 "3 pairs of faces meet" check faults.vtu
check "a page of the model" sh -c "grep -F \"data-simplices='8'\" faults.html && grep -F 'crossing&#10;' faults.html"
"$pbw" convert meet.obj meet.stl --quiet
check "corners are compared by place" says 1 "3 pairs of faces meet" check meet.stl
check "a solid of them" says 0 "the surface meets itself: 3 pairs of faces, the first at (" solid meet.obj --size 1
# A box without a lid, a tetrahedron through the opening.
printf 'v %s\n' '0 0 0' '4 0 0' '4 4 0' '0 4 0' '0 0 4' '4 0 4' '4 4 4' '0 4 4' '2 2 3' '3 2 5' '1 3 5' '1 1 5' > lid.obj
printf 'f %s\n' '1 3 2' '1 4 3' '1 2 6' '1 6 5' '2 3 7' '2 7 6' '3 4 8' '3 8 7' '4 1 5' '4 5 8' '9 10 11' '9 11 12' \
    '9 12 10' '10 12 11' >> lid.obj
check "holes closed by faces that meet others" says 0 "close holes meet the surface or each other: 6 pairs" \
    solid lid.obj --size 1
(cat closed.obj && echo 'v .5 .5 0' && printf 'f %s\n' '2 5 3' '1 2 3') > flat.obj
check "a face without area" says 1 "1 face without area:" check flat.obj -o faults.csv
check "where it is" grep -xF "  4 with a corner at (1, 0, 0)" said
check "a face again" grep -F "1 face given again:" said
check "crowded edges are in the table" grep -E "^crowded edge,,,1,2,1,0,0,0,1,0$" faults.csv
check "a flat face is" grep -E "^flat,4,,,,1,0,0,,,$" faults.csv
check "a surface without faults" says 0 "0 pairs of faces that meet, 0 faces without area, 0 given again" check closed.obj -o none.csv
check "an empty table" sh -c "wc -l < none.csv | grep -x ' *1'"
check "-o of what is no surface" says 1 "-o is for the faults of surfaces" check atoms.csv -o none.csv
check "-o and --retriangulate" early 2 "--retriangulate and .csv exclude each other" check closed.obj --retriangulate -o none.csv

# Meshes: their own simplices are checked, shown and converted.
medit() {   # medit FILE ROWS: five points and tetrahedra
    printf 'MeshVersionFormatted 2\nDimension 3\nVertices 5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 1 1 0\n' > "$1"
    printf "Tetrahedra %s\n$2End\n" "$(printf "$2" | wc -l)" >> "$1"
}
medit two.mesh '1 2 3 4 7\n2 3 4 5 8\n'
check "a mesh" says 0 "2 tetrahedra, 6 facets on the boundary" check two.mesh
check "it is Delaunay or not" grep -F "links are right" said
check "its boundary" grep -F "closed, 1 component" said
check "its volume" grep -F "volume 0.5" said
medit away.mesh '1 3 2 4 7\n2 3 4 5 8\n'
check "a negative simplex is turned" says 0 "1 with negative orientation, turned here; the first: tetrahedron 0" check away.mesh
check "and no fault" grep -F "closed, 1 component" said
medit flat.mesh '1 2 3 4 7\n1 2 3 3 7\n'
check "a flat simplex" says 1 "1 without volume; the first: tetrahedron 1" check flat.mesh
medit crowded.mesh '1 2 3 4 7\n2 3 4 5 8\n1 2 3 5 8\n2 3 4 1 8\n'
check "a facet of three" says 1 "facets of more than two simplices; the first: tetrahedron 0" check crowded.mesh
medit folded.mesh '1 2 3 4 7\n1 2 3 5 8\n'
check "two simplices on one side" says 1 "1 facets with both of their simplices on one side" check folded.mesh
check "--retriangulate proves the points" says 0 "check        " check folded.mesh --retriangulate
check "their triangulation" grep -F "5 points in 3D" said
check "a mesh is shown" says 0 "2 tetrahedra, 6 facets on the boundary" view two.mesh -o two.html
check "as it is" grep -F "data-simplices='2'" two.html
check "a surface is shown" silent view closed.obj --quiet -o surface.html
check "as triangles in space" grep -F "data-simplices='4' data-heights='1' data-surface='1'" surface.html
check "--retriangulate shows tetrahedra" silent view closed.obj --quiet --retriangulate -o surface.html
check "of its points" grep -F "data-dim='3' data-points='4' data-simplices='1'" surface.html
for format in vtu msh msh2 mesh ele node inp su2 face; do
    check "two.mesh as .$format" silent convert two.mesh --quiet copy.$format
done
for format in vtu msh msh2 mesh ele; do
    check "copy.$format has its simplices" says 0 "2 tetrahedra, 6 facets on the boundary" check copy.$format
done
check "a surface is no mesh" says 1 "it has no tetrahedra, and no triangles of one plane" convert closed.obj closed.su2

check "--inside of an open surface" says 0 "warning: the surface is not closed (3 open" mesh open.obj --inside
check "one tetrahedron" says 0 "1 tetrahedron, 4 facets on the hull, 0 duplicates, 0 hidden points" mesh open.obj
printf '0,0\n1,0\n0,1\n' > three.csv
check "one triangle" says 0 "1 triangle, 3 facets" mesh three.csv
check "memory of few points" sh -c "'$pbw' mesh three.csv | grep 'peak memory 0' | grep -v 'a point'"

# What is read: the points and cells of meshes, everything with .gz, molecules, JSON, decimal commas.
for file in m.vtu t.vtu m.msh m.msh2 m.mesh m.ele; do
    check "$file is read" same_mesh m.csv $file
    check "$file.gz is read" sh -c "gzip -c $file > z.$file.gz"
    cp m.node z.m.node
    check "$file.gz is read" same_mesh m.csv z.$file.gz
done
for file in p.vtu p.msh p.mesh p.ele; do
    check "$file is read" same_mesh p.csv $file
done
gzip -c m.csv > m.csv.gz
from_gz() { "$pbw" mesh - < m.csv.gz | grep -o 'hash.*' > one; "$pbw" mesh m.csv | grep -Ff one; }
check "standard input is unpacked" from_gz
head -c 200 m.csv.gz > cut.csv.gz
check "a .gz cut short" says 1 "cut.csv.gz: the compressed data are damaged" mesh cut.csv.gz
sed 1d m.csv | tr ,. ';,' > commas.csv
check "decimal commas" same_mesh m.csv commas.csv --decimal-comma
check "decimal commas without the option" says 1 "decimal commas are read on request" mesh commas.csv
(echo 500; echo a molecule; sed 1d m.csv | sed 's/^/C /' | tr , ' ') > molecule.xyz
check "a molecule" same_mesh m.csv molecule.xyz
(echo '{"type": "MultiPoint", "coordinates": ['; sed 1d m.csv | sed 's/.*/[&],/;$s/,$//'; echo ']}') > m.geojson
check "GeoJSON" same_mesh m.csv m.geojson
(echo 500 3; sed 1d m.csv | tr , ' ') > counts.txt
check "a header of counts" same_mesh m.csv counts.txt
(echo 500 0 0; sed 1d m.csv | tr , ' ') > counts.txt
check "a header that may be a point" says 1 "this looks like a header of counts" mesh counts.txt

# Points that live: changes by a script; the result is, byte for byte, that of pbw mesh of the points it writes.
printf '# some changes\ninsert,0.5,0.25\ninsert,.25,.75\n\nremove,3\ncommit\n' > changes
printf 'move,501, 0.1, 0.1\nmove,5,.3,.3\r\n' >> changes
printf ' commit\nremove,500\nremove,0\ninsert,.5,.5\ninsert,.5,.5\nmove,7,.5,.5\n' >> changes
check "live" says 0 "2 inserted, 1 removed, 0 moved; batch: " live p.csv --script changes -o live.csv -o live.vtu
check "live commits what is left in the end" grep "3: 2 inserted, 2 removed, 1 moved; batch: .* hash" said
check "live: how many points are left" grep "500 points" said
grep -o 'hash.*' said | tail -n 1 > hash
check "live: the hash after the last commit is that of pbw mesh" sh -c \
    "'$pbw' mesh live.csv -o again.vtu | grep -F \"\$(cat hash)\" && [ \$(grep -cF \"\$(cat hash)\" said) = 2 ]"
check "live: equal bytes" cmp live.vtu again.vtu
check "live by the standard input" sh -c "'$pbw' live p.csv --script - < changes | grep -F \"\$(cat hash)\""
printf 'insert,1,1,1.5,9\ninsert,.5,.5,.5\ncommit\nremove,4\ninsert,0.1,.1,.1,-7\n' > weighted
check "live with weights" says 0 "0 duplicates, 2 hidden points" live atoms.csv --weights r --columns x,y,z \
    --script weighted -o live.csv
check "live with weights: as pbw mesh" sh -c \
    "grep -o 'hash.*' said | tail -n 1 > hash && '$pbw' mesh live.csv --weights weight | grep -Ff hash"
printf 'remove,0\nremove,1\ncommit\n' > flat
check "live without a triangle" says 0 "the points span no simplex" live three.csv --script flat
check "live without a triangle writes none" says 1 "the points do not span the space" live three.csv --script flat -o flat.vtu
refused() {   # refused TEXT LINE...
    text=$1
    shift
    printf '%s\n' "$@" > script
    says 1 "script:$#: $text" live p.csv --script script -o refused.vtu && ! [ -e refused.vtu ]
}
check "live: a word" refused '"isnert" is none of insert, remove, move, commit; the nearest is insert' \
    '# a' isnert,1,2
check "live: too few numbers" refused "insert takes x,y or x,y,weight" commit insert,1
check "live: no number" refused "finite numbers with commas between are needed" insert,1,x
check "live: a number that is infinite" refused "finite numbers" insert,1,inf
check "live: a weight" refused "a weight needs --weights" insert,1,2,3
check "live: a point that is not there" refused "there is no point 501" insert,1,2 remove,501
check "live: half a point" refused "there is no point 0.5" move,0.5,1,1
check "live: a point that was removed" refused "there is no point 4: it was removed" remove,4 move,4,1,1
check "live: commit takes no number" refused "commit takes no number" commit,1
check "live needs a script" early 2 "pbw live needs --script" live p.csv
check "live: a script that is not there" early 2 "--script no.csv: No such file" live p.csv --script no.csv
check "live: the script is no output" early 2 "it is an input" live p.csv --script p.vtu -o p.vtu
check "live: out of memory" says 1 "out of memory within --memory-limit 1K" live p.csv --script changes \
    --memory-limit 1K

# Solids: a cube, and one in a cube; the options of pbw solid and pbw improve show in what is reported or written.
cube() {    # cube FIRST LOW HIGH: of points numbered from FIRST on
    awk -v n="$1" -v a="$2" -v b="$3" 'BEGIN {
        for (i = 0; i < 8; i++) print "v", (i % 2 ? b : a), (int(i / 2) % 2 ? b : a), (i > 3 ? b : a)
        m = split("1 3 4 1 4 2 5 6 8 5 8 7 1 2 6 1 6 5 3 7 8 3 8 4 1 5 7 1 7 3 2 4 8 2 8 6", f)
        for (i = 1; i < m; i += 3) print "f", f[i] + n, f[i + 1] + n, f[i + 2] + n }'
}
cube 0 0 1 > cube.obj
(cat cube.obj; cube 8 0.3 0.7) > both.obj
"$pbw" mesh --generate sphere 500 --quiet -o ball.obj
tets() { "$pbw" solid "$@" > said 2>&1; code=$?; count=$(sed -n 's/^\([0-9]*\) tetrahedra in .*/\1/p' said); return $code; }
more() {    # more MODEL OPTIONS OPTIONS: the second ones make more tetrahedra
    # shellcheck disable=SC2086
    tets "$1" $2 && few=$count && tets "$1" $3 && cat said && [ "$count" -gt "$few" ]
}
check "a solid" says 0 "8 corners, 12 sharp edges" solid cube.obj --size 0.3
check "its volume" grep "volume 1, of the surface 1" said
check "its Euler number" grep "Euler number 2, of the surface 2; edges" said
(cube 0 0 1; cube 8 0.5 1.5) > joined.obj
check "a union" says 0 "Euler number 2, of the united surface, contacts counted once, 2;" solid joined.obj --size 0.4
check "--feature-angle" says 0 "0 corners, 0 sharp edges" solid cube.obj --size 0.3 --feature-angle 100
check "--sharp" says 0 "0 corners, 0 sharp edges" solid cube.obj --size 0.3 --sharp none
check "far from the surface" says 0 "sizes apart; a smaller --size" solid cube.obj --size 0.5 --sharp none \
    --least-size 0.5
check "before work" says 0 "sharp edges: all are kept, as 100 %" solid cube.obj --size 0.3
check "--most" says 1 "tetrahedra, more than --most allows" solid cube.obj --size 1e-9
check "a thin wall" says 1 "of the size 30" solid cube.obj --size 30
check "a cavity" says 0 "volume 0.936, of the surface 0.936" solid both.obj --size 0.3
check "--nested" says 0 " in 2 regions, " solid both.obj --size 0.3 --nested
check "--size" more cube.obj "--size 0.4" "--size 0.2"
check "--region-sizes" more both.obj "--size 0.4 --nested" "--size 0.4 --nested --region-sizes 0=1,1=0.05"
for wrong in 1 1=0 =3 1=0.1x 1=0.1,; do
    check "--region-sizes $wrong" says 2 "R=H is needed at" solid both.obj --region-sizes "$wrong"
done
check "--least-size" more both.obj "--size 0.4 --least-size 0.39" "--size 0.4 --least-size 0.05"
check "--distance" more ball.obj "--size 0.8 --distance 0.5" "--size 0.8 --distance 0.03"
check "--curvature" more ball.obj "--size 0.8" "--size 0.8 --curvature 0.4"
check "--around" more ball.obj "--size 0.8" "--size 0.8 --around 16"
check "--gradation" more cube.obj "--size 0.08+0.5*x" "--size 0.08+0.5*x --gradation 0.05"
patches() { tets cube.obj --size 0.3 -o p.face "$@" && [ "$(sed 1d p.face | awk '{ print $5 }' | sort -u | wc -l)" = "$n" ]; }
n=6; check "--patches" patches --patches
n=1; check "no patches" patches
target() { tets cube.obj --size 0.3 --target 15 -o low.msh && "$pbw" improve low.msh "$@" > said && cat said; }
check "improve --target" target --target 32 -o high.vtu
check "its angles" grep '^after: *dihedral angles 3[2-9]' said
brief() { target --target 40 --seconds 1e-9 && grep '; 0 passes$' said; }
check "improve --seconds" brief
features() {    # a file without edges: they are found by their angles, and slide where they are not
    "$pbw" solid cube.obj --size 0.3 --target 15 --quiet -o bare.node -o bare.ele &&
        says 0 "volume 1, before 1" improve bare.ele --target 40 && "$pbw" improve bare.ele --target 40 \
            --feature-angle 100 > said && grep "^volume 0.9" said
}
in_full "improve --feature-angle" features
check "improve --size" says 0 "edges split for sizes: " improve low.msh --size 0.15
errors() {  # as many tetrahedra as --count says, about, where all errors are equal
    count=$(sed -n 's/^\([0-9]*\) tetrahedra in .*/\1/p' said) && yes 1 | head -n "$count" > errors &&
        "$pbw" improve low.msh --error errors --count $((8 * count)) > said && cat said &&
        [ "$(sed -n 's/^improve .* \([0-9]*\) tetrahedra.*/\1/p' said)" -gt $((4 * count)) ]
}
tets cube.obj --size 0.3 --target 15 -o low.msh
check "improve --error --count" errors
check "improve --smooth --rounds" says 0 "before that, 2 rounds of smoothing" improve low.msh --smooth odt --rounds 2
check "improve --only-smooth" says 0 "; 0 passes" improve low.msh --smooth lloyd --only-smooth
check "improve --quality" says 0 "gamma            least" improve low.msh --quality

# Fill: the surface's own triangles; what is refused says where.
check "fill" says 0 "tetrahedra in 1 region, 8 points, 0 of them new, 12 facets on the surface" fill cube.obj
"$pbw" solid cube.obj --size 0.5 --quiet -o both.mesh
check "fill of tetrahedra" says 0 "tetrahedra and their regions are not kept" fill both.mesh
check "a solid of tetrahedra" says 0 "tetrahedra and their regions are not kept" solid both.mesh --size 0.5
check "fill --conforming" says 0 "8 points, 0 of them new, 12 facets" fill cube.obj --conforming
check "fill --split-flat" says 0 "14 points, 6 of them new, 24 facets" fill cube.obj --conforming --split-flat
"$pbw" mesh --generate sphere 60 --quiet -o small.obj
check "fill --target" says 0 "away from the surface: " fill small.obj --target 15 --ratio 1.5 -o filled.vtu
check "fill --target keeps the faces" says 0 ", 116 facets on the surface" fill small.obj --target 15 --seconds 9
check "fill --size" says 0 "too slim, at faces" fill small.obj --size 0.3
check "fill --size: a formula" says 0 "too slim, at faces" fill small.obj --size '0.2+0.3*hypot(x,y)'
check "fill --ratio" says 0 ", 116 facets on the surface" fill small.obj --ratio 1.5 --volume 0.01
fill_count() { "$pbw" fill small.obj --ratio 2 "$@" | sed -n "s/ tetrahedra in .*//p"; }
finer() { [ "$(fill_count --gradation 0.02)" -gt "$(fill_count)" ]; }
check "fill --gradation" finer
check "fill --gradation without use" says 1 "without --size" fill small.obj --size 0.3 --gradation 0.2
check "fill --gradation alone" says 1 "is for --ratio" fill small.obj --gradation 0.2
check "fill --volumes without regions" says 1 "small.obj: --volumes: the file has no regions" fill small.obj --volumes
check "fill: a cavity" says 0 " in 1 region, 16 points" fill both.obj --conforming
check "fill --nested" says 0 " in 2 regions, 16 points" fill both.obj --nested --conforming
check "fill --outside" says 0 " in 3 regions, 24 points" fill both.obj --outside --conforming
sed '$d' cube.obj > lidless.obj
check "fill: open" says 1 "the surface is open: a triangle bounds no region; --outside keeps what is on both \
sides, pbw solid closes it by --close or --wrap" fill lidless.obj
check "fill: flat" says 1 "a triangle has no area; pbw check lists all of them, pbw solid takes" fill flat.obj
sed '1s/.*/v 0.5 0.5 3/' cube.obj > crossed.obj
check "fill: faces that cross" says 1 "pbw check lists all places" fill crossed.obj
seeds_of() {    # seeds_of PLACE...: seeds.poly, a tetrahedron with these places in regions
    printf '4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n4\n1\n3 1 3 2\n1\n3 1 2 4\n1\n3 2 3 4\n1\n3 1 4 3\n0\n%d\n' $#
    for place in "$@"; do echo "1 $place $((${#place} + 1))"; done
}
seeds_of "3 0 .5" > seeds.poly
check "fill: a seed outside" says 1 "seed 0, at 3 0 0.5" fill seeds.poly
seeds_of ".1 .1 .1" ".25 .1 .1" > seeds.poly
check "fill: two seeds" says 1 "seed 1, at 0.25 0.1 0.1" fill seeds.poly
check "fill: the other seed" says 1 "seed 0, at 0.1 0.1 0.1" fill seeds.poly
check "fill --faces" sh -c '"$1" fill cube.obj --faces -o filled.msh2 --quiet &&
    [ "$(awk "NF == 8 && \$2 == 2 { print \$4 }" filled.msh2 | sort -u | wc -l)" = 12 ]' sh "$pbw"

# Sizes, limits, measures and views of solids and of tetrahedra are what they are elsewhere.
edges() {   # edges NAME: the mean length of edges of tetrahedra left and right of x = 0.5, in the corners of NAME.ele
    awk 'FNR == 1 { next }
        FILENAME ~ /node$/ { x[$1] = $2; y[$1] = $3; z[$1] = $4 }
        FILENAME ~ /ele$/ { for (a = 2; a < 6; a++) for (b = a + 1; b < 6; b++) {
            side = x[$a] + x[$b] > 1
            sum[side] += sqrt((x[$a] - x[$b]) ^ 2 + (y[$a] - y[$b]) ^ 2 + (z[$a] - z[$b]) ^ 2); n[side]++ } }
        END { print sum[0] / n[0], sum[1] / n[1] }' "$1.node" "$1.ele"
}
graded() {  # graded COMMAND...: edges on the right are more than 1.5 times those on the left
    "$pbw" "$@" --quiet -o graded.node -o graded.ele && edges graded | awk '{ print; exit !($2 > 1.5 * $1) }'
}
(printf 'ply\nformat ascii 1.0\nelement vertex 8\n'; printf 'property double %s\n' x y z h
 printf 'element face 12\nproperty list uchar int vertex_indices\nend_header\n'
 awk '$1 == "v" { print $2, $3, $4, ($2 > 0 ? 0.3 : 0.08) } $1 == "f" { print 3, $2 - 1, $3 - 1, $4 - 1 }' cube.obj) > cube.ply
check "solid --size: a formula" graded solid cube.obj --size '0.08+0.22*x^2'
check "solid --size: a column" graded solid cube.ply --size h
check "solid --size: a column by its number" graded solid cube.ply --size '#4'
check "solid --size: no formula" says 2 '--size 0.1+: this is no formula from "" on' solid cube.obj --size 0.1+
check "solid --size: no column" says 1 "cube.ply" solid cube.ply --size height
check "solid --size: nothing above 0" says 1 "it is above 0 nowhere" solid cube.obj --size '-1-x'
sed 's/ 0.08$/ 0/' cube.ply > flat.ply
check "solid --size: a column with 0" says 1 "it is 0 at point 0, a number above 0 is needed" solid flat.ply --size h
"$pbw" solid cube.obj --size 0.2 --quiet -o even.node -o even.ele -o even.msh
check "improve --size: a formula" graded improve even.msh --size '0.08+0.22*x^2'
sed '1s/3 0 /3 1 /;2,$s/^\([^ ]* \([^ ]*\) [^ ]* [^ ]*\)/\1 \2/' even.node |
    awk 'NR > 1 && !/^#/ { $5 = 0.08 + 0.22 * $2 ^ 2 } 1' > sized.node
cp even.ele sized.ele
in_full "improve --size: a column" graded improve sized.ele --size '#4'
check "improve --size: a formula that is 0 somewhere" says 1 "it is 0 at point" improve even.msh --size '0.2*x'
check "z is no place in the plane" says 2 'this is no formula from "z" on' plane p.csv --size 0.1+z
for command in solid improve; do
    model=$([ $command = solid ] && echo cube.obj || echo even.msh)
    check "$command --memory-limit" says 1 "within --memory-limit 50K" $command $model --memory-limit 50K
    check "$command --memory-limit that is enough" says 0 "dihedral" $command $model --memory-limit 1G
    check "$command --quality" says 0 "mean" $command $model --quality
    views() {
        "$pbw" $command $model --quiet -o one.svg && "$pbw" $command $model --quiet -o two.svg --eye 1,0.2,0.1 \
            --cut 1,0,0,0 && grep -q '<svg' one.svg && ! cmp one.svg two.svg &&
            says 2 "--cut 1,0,0,0: it needs an output .html or .svg" $command $model --cut 1,0,0,0 -o one.vtu
    }
    check "$command --eye --cut" views
    check "$command --colour round" says 2 "pbw $command moves points, and keeps no record of that" $command $model \
        --colour round -o one.html
done
twice() {
    grep -oEh '[{] "--[a-z-]*", (NULL|"[A-Z])' "$root"/examples/program/*.[ch] |
        sed 's/, .*//' | sort | uniq -d
}
check "each option is defined once" [ -z "$(twice)" ]

# On a terminal each stage has its name while it is at work, and nothing is drawn again that is there.
if script -qec true /dev/null < /dev/null > /dev/null 2>&1; then
    terminal() { script -qec "'$pbw' $*" typed < /dev/null > said; tr '\r' '\n' < typed | sed 's/\x1b\[K//' > frames; }
    stages() {  # stages NAMES ARGUMENT...
        names=$1
        shift
        terminal "$@" && awk '/^[a-z]+ .*(%|[.][.][.])$/ && !($1 in seen) { seen[$1]; line = line $1 " " }
            /%$/ && $0 == before { again = 1 }
            { before = $0 }
            END { print line; exit again }' frames > seen && cat seen frames && [ "$(cat seen)" = "$names " ]
    }
    check "stages of a solid" stages "read sample rounds improve measure write" solid cube.obj --size 0.1 -o cube.vtu
    estimate() { awk '/^rounds/ { exit !before } /^about [0-9]+ tetrahedra/ { before = 1 }' frames; }
    check "the estimate comes before the work" estimate
    check "stages of a plane domain" stages "read order build output plane check measure write" plane p.csv --size 0.01 -o plane.vtu
    check "stages of a triangulation" stages "read order build output check write" mesh m.csv -o typed.vtu
    check "stages of what is inside" stages "read surface order build output check inside write" \
        mesh cube.obj --inside -o typed.vtu
    # An input that is late: seconds are shown until it is there to be read.
    slow() { until grep -q ' [2-9] s' typed || [ ${#waited} = 240 ]; do sleep 0.5; waited=x$waited; done; cat m.csv; }
    late() {
        : > typed
        mkfifo late.csv && { slow > late.csv & } && script -qfec "'$pbw' mesh late.csv -o late.vtu" typed < /dev/null > said &&
            tr '\r' '\n' < typed > frames && grep '^read  *late.csv [.][.][.] [2-9] s' frames && [ -s late.vtu ]
    }
    check "a stage that is silent shows its seconds" late
else
    skip "stages on a terminal: no script"
fi

# Samples.
cube 0 0 1 | awk '$1 == "v" { $4 *= 0.001 } { print }' > sheet.obj
sampled() { "$pbw" sample "$@" --format csv -o - 2> said | sed 1d > points.csv; }
count() { sampled "$@" && wc -l < points.csv; }
check "sample --count" [ "$(count cube.obj --count 300)" = 300 ]
check "sample --radius" says 0 "none closer than 0.1" sample cube.obj --radius 0.1
thick=$(count sheet.obj --radius 0.05)
check "sample --thin" [ "$(count sheet.obj --radius 0.05 --thin)" -gt "$((3 * thick / 2))" ]
check "sample --fill lattice" says 0 "points inside" sample cube.obj --count 300 --fill lattice
check "sample --fill poisson" says 0 "points inside" sample cube.obj --count 300 --fill poisson
check "sample --uniform" says 0 "300 points" sample cube.obj --uniform --count 300
seeds() {
    sampled cube.obj --count 9 && mv points.csv one && sampled cube.obj --count 9 --seed 2 && ! cmp one points.csv
}
check "sample --seed" seeds
normals() {
    [ "$(count cube.obj --count 99 "$@")" = 99 ] && awk -F, '$4 * $4 + $5 * $5 + $6 * $6 != 1' points.csv > bent
}
facets() { normals --facet-normals && ! [ -s bent ] && normals && [ -s bent ]; }
check "sample --facet-normals" facets
check "sample --text" sh -c "'$pbw' sample cube.obj --count 9 --text -o n.ply && grep 'format ascii' n.ply"

# What is written, and what pages show.
printf '0,0\n1,0\n0,1\n1,1\n.5,.5\n.5,.5\n' > twice.csv
points_of() { sed -n 's/.*NumberOfPoints="\([0-9]*\)".*/\1/p' "$1"; }
orphans() { "$pbw" "$@" --quiet -o o.vtu --text && points_of o.vtu; }
check "points that are no corners stay" [ "$(orphans mesh twice.csv)" = 6 ]
check "mesh --no-orphans" [ "$(orphans mesh twice.csv --no-orphans)" = 5 ]
check "plane --no-orphans" [ "$(orphans plane twice.csv --no-orphans)" = 5 ]
printf 'remove,0\n' > fewer
check "live --no-orphans" [ "$(orphans live twice.csv --script fewer --no-orphans)" = 4 ]
any_order() { same_mesh m.csv m.csv --any-order; }
check "mesh --any-order: the same triangulation" any_order
without() { word=$1 && shift && says 0 "" "$@" && ! grep "$word" said; }
check "mesh --no-check" without valid mesh atoms.csv --no-check
check "live --no-check" without valid live p.csv --script changes --no-check
hashes() { "$pbw" live p.csv --script changes --no-hash > said && ! grep 'commit.*hash' said && grep 'hash' said; }
check "live --no-hash" hashes
shown() { text=$1 && shift && "$pbw" "$@" --quiet -o shown.html && grep -- "$text" shown.html; }
for command in "mesh atoms.csv" "view atoms.csv" "live atoms.csv --script fewer"; do
    # shellcheck disable=SC2086
    check "$command --cut-through" shown "data-cap='1'" $command --cut-through
    # shellcheck disable=SC2086
    check "$command --colour-outside" shown "data-plain='0'" $command --colour-outside
    # shellcheck disable=SC2086
    check "$command --title" shown "<title>a name</title>" $command --title "a name"
    # shellcheck disable=SC2086
    check "$command --colour" shown "data-colour='order'" $command --colour order
done
check "solid --title" shown "<title>a name</title>" solid cube.obj --size 0.3 --title "a name"
check "view --points" shown "data-simplices='0'" view atoms.csv --points
views() {   # views COMMAND OPTION VALUE VALUE: two values make two pictures, and two pages
    for ending in svg html; do
        # shellcheck disable=SC2086
        "$pbw" $1 --quiet "$2" "$3" -o one.$ending && "$pbw" $1 --quiet "$2" "$4" -o two.$ending &&
            ! cmp one.$ending two.$ending || return 1
    done
}
for command in "mesh m.csv" "live m.csv --script fewer"; do
    check "$command --up" views "$command" --up 0,0,1 1,0,0
    check "$command --eye" views "$command" --eye 1,2,3 3,2,1
    check "$command --cut" views "$command" --cut 1,0,0,0 0,1,0,0.2
done
printf 'insert,.2,.2,.2\n' > more
inside() {
    says 0 "3 tetrahedra" "$@" --inside --surface closed.obj -o i.vtu -o i.html && grep '^inside .* 3 tetrahedra' said
}
check "live --inside --surface" inside live atoms.csv --script more
check "view --inside --surface" shown "data-kept='1'" view atoms.csv --inside --surface closed.obj

# Options that many commands share.
printf 'a;b\n0,0;0,0\n1,0;0,0\n0,0;1,0\n1,0;1,5\n' > table.csv
printf 'a;b\n0,2;0,2\n' > query.csv
printf 'insert,0.3,0.3\n' > script
shared() {  # shared COMMAND [ARGUMENT...]: reads the table by its options, on two threads within some memory
    says 0 "" "$@" --dim 2 --columns b,a --decimal-comma --threads 2 --memory-limit 500M &&
        says 1 'there is no column "c"' "$@" --columns c,b --decimal-comma &&
        says 1 "out of memory within --memory-limit 1K" "$@" --columns a,b --decimal-comma --memory-limit 1K
}
check "reading keeps --memory-limit" says 1 "table.csv: out of memory within --memory-limit 9" mesh table.csv \
    --memory-limit 9
check "so does --surface" says 1 "--surface: closed.obj: out of memory" mesh --generate uniform 9 --inside \
    --surface closed.obj --memory-limit 300
check "mesh: shared options" shared mesh table.csv
check "check: shared options" shared check table.csv
check "bench: shared options" shared bench table.csv
check "hash: shared options" shared hash table.csv
check "view: shared options" shared view table.csv -o table.html
check "cells: shared options" shared cells table.csv
check "locate: shared options" shared locate table.csv query.csv
check "nearest: shared options" shared nearest table.csv query.csv
check "live: shared options" shared live table.csv --script script
check "tiles: shared options" says 0 "4 points in 2D" tiles table.csv --dim 2 --columns b,a --decimal-comma --no-mesh
check "plane: shared options" says 0 "2 triangles" plane table.csv --dim 2 --columns b,a --decimal-comma --threads 2
check "convert: shared options" says 0 "4 points in 2D" convert table.csv --dim 2 --columns b,a --decimal-comma c.csv
printf '0.2,0.2\n' > query.csv
seeded() {  # seeded COMMAND...: other numbers with another seed
    for seed in 1 2; do
        "$pbw" "$@" --generate uniform 60 --dim 2 --seed $seed > said
        sed '/ s /d; / s$/d; s/peak memory.*hash/hash/' said > $seed.seed
    done
    "$pbw" "$@" --generate uniform 60 --dim 2 | sed '/ s /d; / s$/d; s/peak memory.*hash/hash/' > default
    cmp 1.seed default && ! cmp 1.seed 2.seed
}
for command in mesh check hash cells plane "tiles --no-mesh" "live --script script"; do
    # shellcheck disable=SC2086
    check "$command --generate --seed" seeded $command
done
check "view --generate --seed" says 0 "60 points" view --generate gauss 60 --seed 3 -o v.html
check "convert --generate --seed" says 0 "60 points" convert --generate gauss 60 --seed 3 c.csv
check "locate --generate --seed" says 0 "1 query" locate --generate uniform 60 --dim 2 --seed 3 query.csv
check "nearest --generate --seed" says 0 "1 query" nearest --generate uniform 60 --dim 2 --seed 3 query.csv
check "bench --generate --seed" says 0 "M points/s" bench --generate uniform 60 --dim 2 --seed 3 --threads 2
check "check --weights" says 0 "weighted" check atoms.csv --weights r
check "view --weights" says 0 "weighted" view atoms.csv --weights r -o v.html
check "bench --weights" says 0 "weighted" bench atoms.csv --weights r --threads 1
weighted() {
    "$pbw" hash atoms.csv --weights r --quiet > one && "$pbw" hash atoms.csv --quiet > two && ! cmp one two
}
check "hash --weights" weighted
check "a table in 3D" says 0 "in 3D" cells atoms.csv --columns x,y,z
for command in "mesh t.vtu" "check t.vtu" "convert t.vtu c.csv" "view t.vtu -o v.html" "locate p.csv query.csv" \
    "nearest p.csv query.csv" "cells p.csv" "plane p.csv" "improve low.msh" "solid cube.obj --size .5" \
    "tiles t.vtu --no-mesh" "live p.csv --script script" "sample cube.obj --count 9"; do
    # shellcheck disable=SC2086
    check "$command --quiet" silent $command --quiet
    check "${command%% *} --help" says 0 "usage: pbw" ${command%% *} --help
done
quiet_hash() { "$pbw" hash p.csv --quiet > said && [ "$(wc -c < said)" = 17 ]; }
check "hash --quiet" quiet_hash
check "hash --help" says 0 "usage: pbw hash" hash --help
check "bench --help" says 0 "usage: pbw bench" bench --help
to_output() { command=$1 && shift && "$pbw" "$command" "$@" -o - 2> said > got && [ -s got ]; }
check "sample --format" to_output sample cube.obj --count 9 --format xyz
check "convert --format" sh -c "'$pbw' convert cube.obj - --format off 2> said | grep OFF"
check "view --format" to_output view p.csv --format html
check "cells --format" to_output cells p.csv --format csv
check "nearest --format" to_output nearest p.csv query.csv --format csv
check "plane --format" to_output plane p.csv --format poly
check "improve --format" to_output improve low.msh --format vtu --text
check "solid --format" to_output solid cube.obj --size 0.3 --format .ele
check "solid --text" to_output solid cube.obj --size 0.3 --format vtu --text --rounds 3 --seconds 9 --threads 2
check "live --format" to_output live p.csv --script script --format vtu --text
check "plane --text" to_output plane p.csv --format vtu --text
check "convert --text" to_output convert cube.obj --format ply --text

# Options that would have no effect are refused, before the work.
printf '1 1 1\n' > points.bin
"$pbw" tiles m.csv --tiles 2 -o m.pbwt > said
"$pbw" mesh p.csv --quiet -o flat.msh
useless() { text=$1 && shift && early 2 "$text" "$@"; }
check "--seed alone" useless "--seed 3: it needs --generate" mesh m.csv --seed 3
check "--columns of what is generated" useless "--columns 1,2 and --generate uniform exclude" \
    mesh --generate uniform 9 --columns 1,2
check "--weights of what is generated" useless "--weights 4 and --generate" mesh --generate uniform 9 --weights 4
check "--dim of tiles" useless "--dim 2 and an input .pbwt exclude each other" check m.pbwt --dim 2
check "--columns of records" useless "--columns 1,2 and an input .bin exclude" \
    tiles points.bin --no-mesh --columns 1,2
check "--tile without tiles" useless "--tile 1: it needs an input .pbwt" convert m.csv --tile 1 c.csv
check "--eye without a picture" useless "--eye 1,2,3: it needs an output .html or .svg" \
    mesh m.csv --eye 1,2,3 -o a.vtu
check "--title without a page" useless "--title T: it needs an output .html" mesh m.csv --title T -o a.svg
check "--text of text" useless "--text: it needs an output .vtu, .msh, .ply or .stl" mesh m.csv --text -o a.csv
check "--no-orphans of a picture" useless "--no-orphans: it needs an output .vtu" mesh m.csv --no-orphans -o a.svg
check "--format beside endings" useless "--format obj: it needs an output whose name tells no other format" \
    mesh m.csv --format obj -o a.vtu
check "--format alone" useless "--format obj: it needs an output" mesh m.csv --format obj
check "points with threads" useless "--points and --threads 2 exclude each other" \
    view m.csv --points --threads 2 -o a.html
check "points with colours of simplices" useless "--colour part and --points exclude" \
    view m.csv --points --colour part -o a.html
check "live: colours of threads" useless "--colour thread: pbw live" \
    live m.csv --script changes --colour thread -o a.html
check "--count and --radius" useless "--count 5 and --radius 1 exclude each other" \
    sample cube.obj --count 5 --radius 1
check "--uniform and --fill" useless "--uniform and --fill lattice exclude" sample cube.obj --uniform --fill lattice
check "normals that are not written" useless "--facet-normals and --fill poisson exclude" \
    sample cube.obj --facet-normals --fill poisson -o a.ply
check "--box and --clip" useless "--box 0,0,1,1 and --clip p.csv exclude" cells p.csv --box 0,0,1,1 --clip p.csv
check "plane: weights" useless "pbw plane has no option --weights" plane p.csv --weights z
check "plane: --rounds alone" useless "--rounds 3: it needs --smooth" plane p.csv --rounds 3
check "plane: --most alone" useless "--most 3: it needs --angle, --area, --size or --conforming" plane p.csv --most 3
check "plane: --steiner alone" useless "--steiner 3: it needs --angle, --area, --size or --conforming" \
    plane p.csv --steiner 3
check "improve: --only-smooth alone" useless "--only-smooth: it needs --smooth" improve low.msh --only-smooth
check "improve: --count alone" useless "--count 9: it needs --error" improve low.msh --count 9
check "improve: --rounds alone" says 2 "--rounds 3: it needs --smooth" improve low.msh --rounds 3
check "improve: a target for triangles" says 2 "--target 20: it is for tetrahedra, flat.msh has triangles" \
    improve flat.msh --target 20

# What has no result is no file.
awk 'BEGIN { for (i = 0; i < 9; i++) for (k = 0; k < 9; k++) print "v", i, k, (i * 7 + k * 3) % 5 / 10
    for (i = 0; i < 8; i++) for (k = 1; k < 9; k++) {
        a = 9 * i + k; print "f", a, a + 9, a + 1; print "f", a + 1, a + 9, a + 10 } }' > sheet.obj
{   # a box without its lid
    printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n'
    printf 'f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n'
} > bowl.obj
printf 'x,y,z\n90,90,90\n91,90,90\n90,91,90\n90,90,91\n' > away.csv
none() {    # none TEXT ARGUMENT...: status 1, a piece of the message, and no output
    rm -f none.* && says 1 "$@" && ! ls none.*
}
check "mesh --inside of a sheet" none "sheet.obj: nothing is inside: the surface is an open sheet" \
    mesh sheet.obj --inside -o none.vtu
check "mesh --inside of a bowl" says 0 "6 tetrahedra" mesh bowl.obj --inside
check "mesh --inside of what is elsewhere" none "closed.obj: nothing is inside: no tetrahedron" \
    mesh away.csv --inside --surface closed.obj -o none.msh -o none.ele
check "view --inside of what is elsewhere" none "closed.obj: nothing is inside" \
    view away.csv --inside --surface closed.obj -o none.html
check "solid of a sheet" none "sheet.obj: it is open: 1 hole, 97 % as large as its faces" \
    solid sheet.obj --size 0.7 -o none.vtu
printf 'x,y\n0,0\n1,0\n0,1\n' > three.csv
check "cells that are all unbounded" none "none.vtu: no cell is bounded: --box or --clip" cells three.csv -o none.vtu
check "GeoJSON of cells that are all unbounded" none "no cell is bounded" cells three.csv -o none.geojson

# Heights and columns go through the triangulation of points.
printf 'x,y,z\n0,0,12\n20,0,15\n20,20,11\n0,20,14\n9,11,31\n0,0,7\n' > hill.csv
hill() {
    says 0 "1 point is on another and of another height" mesh hill.csv --dim 2 -o hill.obj -o hill.node \
        -o hill.csv2.csv -o hill.svg -o hill.html && grep -qx 'v 9 11 31' hill.obj && [ "$(grep -c '^v' hill.obj)" = 5 ] &&
        grep -qx '4 9 11 31 0' hill.node && grep -qx '5 0 0 12 0' hill.node && grep -qx '20,20,11' hill.csv2.csv
}
check "heights with --dim 2" hill
check "heights that an output lacks" says 0 "hill.svg: the format .svg has no place for: heights" mesh hill.csv \
    --dim 2 -o hill.svg
level() {   # all points of one z: in the plane, and at that height again
    sed 's/,[0-9]*$/,3.5/;1s/.*/x,y,z/' hill.csv > level.csv && says 0 "6 points in 2D" mesh level.csv -o level.obj &&
        [ "$(grep -c '^v .* 3.5$' level.obj)" = 5 ]
}
check "points of one z" level
printf '4 2 1 1\n1 0 0 1.5 2\n2 4 0 2.5 2\n3 4 3 3.5 -9\n4 0 3 4.5 0\n' > from1.node
numbered() {    # attributes, markers and numbers go through; the weight is no attribute twice
    says 0 "2 triangles" mesh from1.node -o to1.node -o to1.ele -o to1.csv && cmp from1.node to1.node &&
        awk 'NR > 1 && ($1 < 1 || $2 < 1 || $3 < 1 || $4 < 1) { exit 1 }' to1.ele &&
        [ "$(sed -n 4p to1.csv)" = 4,3,3.5,-9 ] &&
        says 0 "weighted" mesh from1.node --weights 3 -o w.node && [ "$(sed -n 2p w.node)" = "1 0 0 1.5 2" ]
}
check "attributes and numbers of a .node file" numbered

# Parts of a triangulation by size: each simplex beside its edges and its radius by other formulas.
cat > measure.awk << 'END'
function edge(a, b) { return sqrt((x[a] - x[b]) ^ 2 + (y[a] - y[b]) ^ 2 + (z[a] - z[b]) ^ 2) }
FILENAME ~ /node$/ && FNR > 1 && !/^#/ { x[$1] = $2; y[$1] = $3; z[$1] = dim == 3 ? $4 : 0 }
FILENAME ~ /ele$/ && FNR > 1 && !/^#/ {
    a = edge($2, $3); b = edge($3, $4); c = edge($4, $2); most = a > b ? a : b; most = most > c ? most : c
    if (dim == 2) {                                 # the radius: Heron
        radius = a * b * c / sqrt((a + b + c) * (-a + b + c) * (a - b + c) * (a + b - c))
    } else {                                        # products of opposite edges, and the volume
        p = edge($5, $2); q = edge($5, $3); r = edge($5, $4)
        most = most > p ? most : p; most = most > q ? most : q; most = most > r ? most : r
        ux = x[$3] - x[$2]; uy = y[$3] - y[$2]; uz = z[$3] - z[$2]
        vx = x[$4] - x[$2]; vy = y[$4] - y[$2]; vz = z[$4] - z[$2]
        wx = x[$5] - x[$2]; wy = y[$5] - y[$2]; wz = z[$5] - z[$2]
        volume = ux * (vy * wz - vz * wy) - uy * (vx * wz - vz * wx) + uz * (vx * wy - vy * wx)
        p *= b; q *= c; r *= a
        radius = sqrt((p + q + r) * (-p + q + r) * (p - q + r) * (p + q - r)) / (4 * (volume < 0 ? -volume : volume))
    }
    if (most <= longest && radius <= alpha) print $2, $3, $4, $5
}
END
corners() { awk 'NR > 1 && !/^#/ { print $2, $3, $4, $5 }' "$1"; }
parts() {    # parts DIM LONGEST ALPHA FEWER OPTION...: some are kept, fewer than FEWER, and they are those of measure.awk
    awk -v dim="$1" -v longest="$2" -v alpha="$3" -f measure.awk all$1.node all$1.ele > expected
    dim=$1 fewer=$4
    shift 4
    "$pbw" mesh all$dim.csv --quiet "$@" -o part.ele && corners part.ele > found && cmp expected found \
        && [ "$(wc -l < found)" -gt 20 ] && [ "$(wc -l < found)" -lt "$fewer" ]
}
for dim in 2 3; do
    "$pbw" mesh --generate uniform 150 --dim $dim --quiet -o all$dim.csv -o all$dim.node -o all$dim.ele
    all=$(corners all$dim.ele | wc -l)
    check "mesh --longest in ${dim}D" parts $dim 0.4 1e300 "$all" --longest 0.4
    check "mesh --alpha in ${dim}D" parts $dim 9 0.22 "$all" --alpha 0.22
    check "mesh --longest and --alpha in ${dim}D" parts $dim 0.3 0.2 "$all" --alpha 0.2 --longest 0.3
    check "mesh --alpha that keeps all in ${dim}D" parts $dim 1e300 1e300 $((all + 1)) --alpha 1e300
done
check "what is long is named" says 1 "nothing is left: the shortest longest edge is " mesh all2.csv --longest 1e-9
check "mesh --longest 0" says 2 "--longest 0: a number above 0 is needed" mesh all2.csv --longest 0
printf '0,0\n3,0\n3,4\n0,4\n' > box.csv
check "an edge as long as allowed" says 0 "2 of 2 triangles" mesh box.csv --longest 5
check "a radius as large as allowed" says 0 "2 of 2 triangles" mesh box.csv --alpha 2.5
check "a radius that is larger" says 1 "the least radius 2.5" mesh box.csv --alpha 2.499
printf '0,0\n3e-170,0\n3e-170,4e-170\n0,4e-170\n' > tiny.csv
check "lengths below the root of the least number" says 0 "2 of 2 triangles" mesh tiny.csv --longest 5.1e-170 --alpha 2.6e-170
printf '0,0,1\n2,0,1\n0,2,1\n' > heavy.csv
check "the orthogonal circle of three balls" says 0 "1 of 1 triangle" mesh heavy.csv --weights 3 --alpha 1.0000001
check "and it is no smaller" says 1 "the least radius 1" mesh heavy.csv --weights 3 --alpha 0.9999999
check "parts in a picture, a page and GeoJSON" says 0 "parts" mesh all2.csv --longest 0.1 -o part.svg -o part.html -o part.geojson
check "the parts alone" [ "$(grep -c Polygon part.geojson)" = "$(sed -n 's/^parts .* \([0-9]*\) of .*/\1/p' said)" ]

# Numbers and nouns agree.
check "1 point" says 1 "1 point in 2D, 0 faces" mesh query.csv
check "1 query" says 0 "1 query" nearest p.csv query.csv
check "1 turned edge" sh -c "sed 's/f 1 2 4/f 1 4 2/' closed.obj | '$pbw' check - | grep -v '1 [a-z]*s'"
# Habits: values behind =, options of one letter, other spellings, sizes with units; the help and what it shows.
check "pbw alone" says 0 "pbw solid    --help"
check "-h" says 0 "usage: pbw nearest" nearest -h
check "a value behind =" says 0 "5 points in 2D" mesh --dim=2 --columns=x,y atoms.csv
check "a value behind = is checked" early 2 "--threads 1000: a whole number" mesh atoms.csv --threads=1000
check "a switch takes none" early 2 "--quiet takes no value" mesh atoms.csv --quiet=1
check "an option behind = that is misspelt" early 2 "the nearest is --threads" mesh atoms.csv --thraeds=3
check "--generate=KIND N" says 0 "60 points" hash --generate=gauss 60 --memory-limit=1GiB
check "-oFILE" silent mesh atoms.csv --quiet -ojoined.obj
check "it is written" [ -s joined.obj ]
check "--output" silent mesh atoms.csv --quiet --output long.obj --output=longer.obj
check "they are written" [ -s long.obj -a -s longer.obj ]
check "--color" silent mesh atoms.csv --quiet --color=order -o colour.html
check "-x is near to nothing" sh -c "'$pbw' mesh atoms.csv -x 2>&1 | grep -v nearest | grep 'see pbw mesh --help'"
for size in 1GB 1GiB 1g 1.5G 2T 900MB; do
    check "--memory-limit $size" says 0 "5 points" mesh atoms.csv --memory-limit $size
done
for size in 1GX 1iB GB -1G 1Gi; do
    check "--memory-limit $size is refused" early 2 "--memory-limit $size: a number of bytes" mesh atoms.csv \
        --memory-limit $size
done
check "KB are thousands" says 1 "within --memory-limit 1MB" mesh --generate uniform 50000 --memory-limit 1MB
check "an angle out of range" early 2 "--angle 40: a number above 0 and up to 34 is needed" plane m.csv --angle 40
check "a size below 0" early 2 "--size -1: a number above 0, a formula or a column" plane m.csv --size -1
check "the only format of -" sh -c "'$pbw' nearest atoms.csv atoms.csv --columns x,y,z -o - 2> said | grep ','"
mkdir -p given
cp closed.obj given/model.obj
"$pbw" mesh --quiet --generate uniform 60 -o given/points.csv -o given/queries.csv -o given/mesh.msh
printf 'insert,0.5,0.5,0.5\nremove,3\ncommit\n' > given/changes.csv
printf '4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n' > given/domain.poly
"$pbw" tiles --quiet given/points.csv -o given/mesh.pbwt
example() { # example ARGUMENTS: of the help, in a folder that has the inputs and nothing that others wrote
    rm -rf shown && cp -r given shown && sh -c "cd shown && '$pbw' $1 < /dev/null"
}
tells_formats() {   # tells_formats COMMAND: but for texts; live has those of mesh
    "$pbw" $1 atoms.csv $(case $1 in locate | nearest) echo atoms.csv ;; esac) -o x.none > said 2>&1
    case $1 in bench | hash) grep 'has no option -o' said; return ;; esac
    for ending in $(sed -n 's/.*; pbw [a-z]* writes //p' said); do
        case $1.$ending in live.* | *.txt | *.pts | *.asc | *.dat | *.tsv) continue ;; esac
        grep "[.]$ending\>" help.txt || return 1
    done
    grep "; pbw $1 writes [a-z]" said
}
for command in mesh sample check convert bench view locate nearest cells plane improve solid fill wrap tiles hash live; do
    "$pbw" help $command > help.txt
    sed -n '/^examples:/,$s/^  pbw //p' help.txt > shown.txt
    check "the help of $command has the formats that it writes" tells_formats $command
    check "the help of $command ends with two examples" [ "$(wc -l < shown.txt)" -eq 2 ]
    while read -r line; do
        check "pbw $line" example "$line"
    done < shown.txt
done
tells_its_own() {   # the help of an option that commands share has no meaning that another command gives it
    "$pbw" help sample > one.txt && "$pbw" help improve > two.txt && "$pbw" help plane > three.txt &&
        "$pbw" help solid > four.txt && ! grep -e '--error' one.txt && ! grep 'points on the surface, def' two.txt &&
        ! grep -E 'in pbw improve|the default of triangles' three.txt four.txt &&
        ! grep 'adding points' two.txt three.txt && ! grep 'of --smooth' four.txt && grep 'of --smooth' two.txt
}
check "the help of a shared option is the command's own" tells_its_own
check "the manual page" sh -c "'$pbw' help --man | grep '^.SH PBW solid'"
"$pbw" help --bash > pbw.bash
completes() {   # completes ANSWER WORD...
    bash -c '. ./pbw.bash; answer=$1; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _pbw
        [ "${COMPREPLY[*]}" = "$answer" ]' bash "$@"
}
if command -v bash > /dev/null; then
    check "completion for bash: choices" completes "hull seeds even-odd nonzero" pbw plane --rule ""
    check "completion for bash: commands" completes solid pbw sol
    check "completion for bash: options" completes "--curvature" pbw solid model.obj --cur
fi
check "completion for zsh" sh -c "'$pbw' help --zsh > _pbw && { ! command -v zsh || zsh -n _pbw; }"

# Groups of a surface become patches by name, and stay with the mesh when it is improved.
box() { # box NAME X0 X1: the end of a bar at x = X0, turned out of it, in two facets
    printf 'solid %s\n' "$1"
    printf 'facet normal 0 0 0\nouter loop\nvertex %s\nvertex %s\nvertex %s\nendloop\nendfacet\n' "$2" "$3" "$4" \
        "$2" "$4" "$5"
    printf 'endsolid %s\n' "$1"
}
(box inlet '0 0 0' '0 0 1' '0 1 1' '0 1 0'; box outlet '2 0 0' '2 1 0' '2 1 1' '2 0 1'
    box wall '0 0 0' '2 0 0' '2 0 1' '0 0 1'; box wall '0 1 0' '0 1 1' '2 1 1' '2 1 0'
    box wall '0 0 0' '0 1 0' '2 1 0' '2 0 0'; box wall '0 0 1' '2 0 1' '2 1 1' '0 1 1') > bar.stl
check "patches by name, listed" says 0 "inlet: " solid bar.stl --size 0.3 --patches -o bar.msh2 -o bar.su2 -o bar.vtu
check "patches that sharp edges cut" says 0 "patch 4 wall_2: 46 facets, area 2, centre (1, 1, 0.5)" \
    solid bar.stl --size 0.4 --split-patches -o split.msh2 -o split.inp -o split.su2 -o split.vtu -o split.html
check "one that they do not cut" grep -q '^patch 2 outlet: .* area 1, centre (2, 0.5, 0.5)$' said
check "in .msh2, by names and tags" sh -c '[ "$(sed -n "/^2 [1-9]/p" split.msh2 | sed 6q | tr -d "\n")" = \
    "2 1 \"inlet\"2 2 \"outlet\"2 3 \"wall_1\"2 4 \"wall_2\"2 5 \"wall_3\"2 6 \"wall_4\"" ]'
check "in .inp" sh -c '[ "$(grep -c "NAME=wall_[1-4]$" split.inp)" = 4 ]'
check "in .su2" sh -c 'grep -q "^NMARK= 6$" split.su2 && grep -q "MARKER_TAG= wall_4" split.su2'
check "in a page" grep -q wall_3 split.html
printf 'v 0 0 0\nv 2 0 0\nv 0 1 0\nv 2 1 0\nv 0 0 1\nv 2 0 1\nv 0 1 1\nv 2 1 1\n' > corners.obj
(cat corners.obj; printf 'f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n') > plain.obj
for option in --patches --split-patches; do
    check "$option without groups" says 0 "patch 6 patch_5: 42 facets, area 2, centre (1, 0.5, 1)" \
        solid plain.obj --size 0.4 $option -o plain.msh2
    check "the same in the file" grep -q '^2 6 "patch_5"$' plain.msh2
done
sed '$d' plain.obj > lid.obj
check "a wrap" says 0 "in 1 component, " wrap lid.obj --alpha 0.5 -o wrapped.stl -o wrapped.msh2
check "it is closed" says 0 "closed, 1 component" check wrapped.stl
check "so are its tetrahedra" says 0 "links are right, Delaunay" check wrapped.msh2
check "a shell, and the remedy" says 0 "around both sides of the model, which is open; --alpha " wrap lid.obj --alpha 0.2
closing=$(sed -n 's/.* --alpha \(.*\) closes it/\1/p' said)
printf '0 0 0\n1 0 0\n0 1 0\n0 0 1\n' > four.xyz
check "shells around points" says 0 "thin shell around points or segments alone; " wrap four.xyz
check "points are no surface" says 1 "four.xyz: it has no faces; pbw solid --wrap encloses its points" solid four.xyz
check "the remedy works" sh -c "'$pbw' wrap lid.obj --alpha $closing > closed.txt 2>&1 && ! grep shell closed.txt"
check "a wrap keeps groups" says 0 "" wrap bar.stl --alpha 0.3 -o wrapped.vtu -o groups.msh2
check "their names and tags" sh -c '[ "$(sed -n "/^2 [1-9]/p" groups.msh2 | sed 3q | tr -d "\n")" = \
    "2 1 \"inlet\"2 2 \"outlet\"2 3 \"wall\"" ]'
printf '0.5 0.5 0.5\n9 9 9\n' > seeds.xyz
(cube 0 0 1; cube 8 0.1 0.9) > hollow.obj
check "a cavity with a seed" says 0 "in 2 components, " wrap hollow.obj --alpha 0.2 --offset 0.01 --cavities seeds.xyz
check "a seed outside" grep -q "1 seed is nearer to the model than alpha, or outside of its box" said
(cat lid.obj; printf 'v 9 9 9\n') > spare.obj
check "a spare point is told" says 0 "1 point of no face or segment is left out; --all-points" wrap spare.obj --alpha 0.5
check "and wrapped" says 0 "in 2 components, " wrap spare.obj --alpha 0.5 --all-points
check "tetrahedra are wrapped" says 0 "in 1 component, " wrap wrapped.msh2 --alpha 0.5
printf '1 1 1\n1 1 1\n' > still.xyz
check "all at one place" says 1 "still.xyz: all of it is at one place; --alpha says" wrap still.xyz
printf '1e12 1 1\n1e12 2 3\n' > distant.xyz
check "far from the origin" says 1 "is below 1e-9 of its largest coordinate; a larger --offset" wrap distant.xyz
check "solid --wrap" says 0 "below 5, 10, 20, 30: 0, 0, 0, " solid lid.obj --wrap --size 0.5 --alpha 0.6 -o filled.vtu
check "both distances" grep -q "the boundary is up to .* sizes from the boundary" said
check "a solid of points" says 0 "7 tetrahedra, 7 points" solid seeds.xyz --wrap --size 4 --alpha 20 --target 20
check "solid --wrap --size: a formula" says 2 "with --wrap it is a number above 0" solid lid.obj --wrap --size x
check "solid --wrap --sharp" says 2 "--wrap and --sharp none exclude each other" solid lid.obj --wrap --sharp none
check "solid --alpha alone" says 2 "--alpha 1: it needs --wrap" solid lid.obj --alpha 1
check "wrap --most" says 1 "more tetrahedra than --most allows" wrap lid.obj --most 100
check "wrap --seconds" says 1 "--seconds were over before there was a wrap" wrap lid.obj --seconds 1e-9
check "solid --wrap --seconds" says 1 "--seconds were over before" solid lid.obj --wrap --seconds 1e-9
printf 'v 0 0 0\nv 4 0 0\nv 4 1 0.5\nv 0 1 0\nf 1 2 3 4\n' > sheet.obj
check "a sheet becomes a plate" says 0 "below 5, 10, 20, 30: 0, 0, 0, " solid sheet.obj --wrap --size 0.4
check "1/4 of the size thick" grep -q "the model up to 0.125 sizes from the boundary" said
check "a closed model is filled by its wrap" says 0 "below 5, 10, 20, 30: 0, 0, 0, " solid plain.obj --wrap --size 0.2 \
    -o around.off
check "and points are pulled onto it" says 0 "volume 2.0" check around.off
check "solid --wrap --offset" says 0 "0, 0, 0, 0" solid plain.obj --wrap --size 0.2 --offset 0.025 -o around.off
check "keeps them off it" says 0 "volume 2.2" check around.off
facets() { sed -n 's/ facets in .*//p' said; }
check "wrap --alpha: a formula" says 0 "in 1 component, " wrap lid.obj --alpha "0.1+0.4*x" --offset 0.02
graded=$(facets)
check "its least value" says 0 "in 1 component, " wrap lid.obj --alpha 0.1 --offset 0.02
check "has more facets" [ "$graded" -lt "$(facets)" ]
check "its largest" says 0 "in 1 component, " wrap lid.obj --alpha 0.5 --offset 0.02
check "has fewer" [ "$graded" -gt "$(facets)" ]
check "wrap --alpha: no formula" says 2 "--alpha 0.1+q: this is no formula from" wrap lid.obj --alpha 0.1+q
check "wrap --alpha: nowhere above 0" says 1 "--alpha -x: it is above 0 nowhere" wrap lid.obj --alpha -x
printf 'x,y,z,reach\n0,0,0,0.1\n1,0,0,0.1\n0,1,0,0.1\n3,3,3,0.8\n' > reach.csv
check "wrap --alpha: a column" says 0 "alpha 0.8, offset 0.00333333" wrap reach.csv --alpha reach
sed '3s/0.1$/0/' reach.csv > zero.csv
check "wrap --alpha: a column with 0" says 1 "it is 0 at point 1" wrap zero.csv --alpha reach
{ printf 'MeshVersionFormatted 2\nDimension 3\nVertices 5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 1 1 0\n'
  printf 'Tetrahedra 2\n1 2 3 4 1\n2 3 4 5 2\nEnd\n'; } > regions.mesh
check "wrap of regions" says 0 "a wrap is one region: those of its tetrahedra are not kept" wrap regions.mesh
check "a hole is listed" says 0 "hole: 46 facets, area 2, centre (1, 0.5, 1)" solid lid.obj --size 0.4 --patches
for word in g o usemtl; do
    (cat corners.obj; echo "$word in let"; echo f 1 5 7 3; echo "$word outlet"; echo f 2 4 8 6; echo "$word wall"
        sed -n '11,$p' plain.obj) > group.obj
    check "$word of an .obj, listed" says 0 "outlet: 26 facets, area 1, centre (2, 0.5, 0.5)" \
        solid group.obj --size 0.4 --patches -o group.msh -o group.msh2 -o group.inp -o group.su2 -o group.vtu
    check "$word: names in .msh2" sh -c 'grep -q "^2 1 .in.*let.$" group.msh2 && grep -q "^2 3 .wall.$" group.msh2'
    check "$word: names in .msh" sh -c 'grep -q "^2 2 .outlet.$" group.msh'
    check "$word: surfaces in .inp" sh -c '[ "$(grep -c "^\*SURFACE.*NAME=\(outlet\|wall\)$" group.inp)" = 2 ]'
    check "$word: markers in .su2" sh -c 'grep -q "^NMARK= 3$" group.su2 && grep -A 1 "MARKER_TAG= outlet" group.su2 |
        grep -q "MARKER_ELEMS= 26"'
    for file in group.msh2 group.msh group.vtu; do
        cp $file back.${file#group.}
    done
    cp group.msh2 back2.msh
    for file in back2.msh back.msh back.vtu; do
        check "$word: patches of $file, improved" says 0 "volume 2, before 2" improve $file --target 32 -o again.msh2
        check "$word: still three of the same area" sh -c '[ "$(sed -n "/^.Elements/,/^.EndElements/p" again.msh2 |
            awk "\$2 == 2 { n[\$4]++ } END { for (i in n) k++; print k }")" = 3 ]'
    done
done
check "a .msh2 file has their names" grep -q '^2 3 "wall"$' bar.msh2
check "a .su2 file has a marker a patch" sh -c '[ "$(grep MARKER_TAG bar.su2 | tr -d "\n")" = \
    "MARKER_TAG= inletMARKER_TAG= outletMARKER_TAG= wall" ]'
cp bar.msh2 bar2.msh
check "a mesh with groups is improved" says 0 "volume 2, before 2" improve bar2.msh --size 0.25 -o better.msh2
check "and has them still" sh -c 'grep -q "^2 1 .inlet.$" better.msh2 && grep -q "^3 1 .region_0.$" better.msh2'

# Second-order elements are read as straight ones, with a word; groups stay, points within edges go.
points='0 0 0  1 0 0  0 1 0  0 0 1  1 1 1'
middles=$(echo "$points 1 2 2 3 3 1 1 4 3 4 2 4 2 5 3 5 4 5" | awk '{ for (i = 16; i < NF; i += 2) {
    a = 3 * $i; b = 3 * $(i + 1)
    print ($(a - 2) + $(b - 2)) / 2, ($(a - 1) + $(b - 1)) / 2, ($a + $b) / 2 } }')
all=$(echo $points | xargs -n 3; echo "$middles")
(printf '$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 7 "rock"\n2 9 "floor"\n$EndPhysicalNames\n'
    printf '$Nodes\n14\n'
    echo "$all" | awk '{ print NR, $0 }'
    printf '$EndNodes\n$Elements\n3\n1 11 2 7 1  1 2 3 4 6 7 8 9 10 11\n2 11 2 7 1  2 3 4 5 7 10 11 12 14 13\n'
    printf '3 9 2 9 1  1 3 2 8 7 6\n$EndElements\n') > second.msh
(printf '# vtk DataFile Version 3.0\nsecond\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 14 double\n%s\n' "$all"
    echo CELLS 2 22
    printf '10 0 1 2 3 5 6 7 8 10 9\n10 1 2 3 4 6 9 10 11 12 13\nCELL_TYPES 2\n24\n24\n') > second.vtk
for file in second.msh second.vtk; do
    check "improve: $file has second-order elements" says 0 \
        "$file: not kept: the points within edges and faces of second-order elements, which are read as straight" \
        improve $file -o straight.msh2
    check "$file: two tetrahedra of five points" sh -c 'sed -n "/^.Nodes/{n;p;}" straight.msh2 | grep -qx 5 &&
        [ "$(sed -n "/^.Elements/,/^.EndElements/p" straight.msh2 | awk "\$2 == 4" | wc -l)" = 2 ]'
    check "$file: their volume" grep -q '^volume 0.5, before 0.5$' said
    [ $file = second.vtk ] || check "$file: its groups" sh -c 'grep -q "^3 7 .rock.$" straight.msh2 &&
        grep -q "^2 9 .floor.$" straight.msh2 && [ "$(grep -c "^[0-9]* 2 2 9 9 " straight.msh2)" = 1 ]'
done
for ending in inp su2; do
    check "groups go into .$ending" says 0 "facets on the boundary" convert bar2.msh -o one.$ending
    check "and come out of it" says 0 "facets on the boundary" convert one.$ending -o two.$ending
    check "as they were" sh -c "sort one.$ending > sorted && sort two.$ending | cmp - sorted"
done
check "and into .ele, .node and .face" says 0 "facets on the boundary" convert bar2.msh -o one.ele -o one.face
check "and come out of them" says 0 "facets on the boundary" convert one.ele -o two.ele -o two.face
check "as they were" sh -c 'cmp one.ele two.ele && cmp one.node two.node && cmp one.face two.face && ! grep " -1$" one.face'
check "a .face file that is read with .ele is no output" says 2 "it is an input" convert one.ele -o one.face
for word in 'inp: edges' 'su2: edges' 'mesh: names of groups' 'off: patches, edges'; do
    check "what .${word%%:*} has no place for" says 0 "the format .${word%%:*} has no place for: ${word#*: }" improve bar2.msh \
        -o lost.${word%%:*}
done
check "what a set of files has no place for" says 0 "has no place for: edges, names of groups" improve bar2.msh -o lost.ele \
    -o lost.face
check "and says it once" sh -c '[ "$(grep -c "no place" said)" = 1 ]'

# Surfaces with groups from any format to any other.
"$pbw" convert --quiet bar.stl -o bar.obj
for ending in vtu msh msh2 inp obj; do
    cp bar.obj one.obj
    check "a surface as .$ending" silent convert one.obj --quiet -o surface.$ending
    check "and back" silent convert surface.$ending --quiet -o back.obj
    check "with its groups" sh -c 'grep -v "^v" bar.obj > faces && grep -v "^v" back.obj | cmp - faces && grep -q "^g wall" faces'
done
check "a surface as .stl with groups" silent convert bar.obj --quiet --text -o bar2.stl
check "solids by name" sh -c '[ "$(grep -a "^solid" bar2.stl | tr "\n" ,)" = "solid inlet,solid outlet,solid wall," ]'
check "binary .stl has no groups, and says so" says 0 "the format .stl has no place for: groups of triangles" convert bar.obj \
    -o bar3.stl
check "a surface is no .su2" says 1 "it has no tetrahedra, and no triangles of one plane" convert bar.obj -o bar3.su2
printf 'MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\nTetrahedra\n1\n1 2 3 4 7\n' > r.mesh
check "a mesh with regions alone" silent convert r.mesh --quiet -o r.msh2 -o r.vtu
check "gets no groups of facets" sh -c 'grep -q "^3 1\|^1 4 2 7 7" r.msh2 && ! grep -q boundary r.msh2'
sed 's/"inlet"/"wall side"/; s/"outlet"/"wall_side"/' bar2.msh > words.msh
check "names that become one word" says 0 'names of groups are words there: "wall side" is wall_side, "wall_side" is wall_side_2' \
    convert words.msh -o words.su2
check "stay apart" sh -c '[ "$(grep -c "TAG= wall_side\|TAG= wall_side_2" words.su2)" = 2 ]'
check "formats without patches say so" says 0 "has no place for: patches" improve bar2.msh -o better.off
finish
