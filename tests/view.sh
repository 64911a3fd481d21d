#!/bin/sh
# view.sh FOLDER: pages of examples/lib/pbw_view.h and pbw_film.h, made by the programs pbw, terrain and swarm in
# FOLDER, in a headless Chromium, which tests/view.mjs drives; it looks at the pixels.
bin=$1 work=$1/view
for browser in "${CHROMIUM:-chromium}" chromium-browser google-chrome ''; do
    [ -n "$browser" ] && "$browser" --version > /dev/null 2>&1 && break
done
if [ -z "$browser" ] || ! node -e 'process.exit(parseInt(process.versions.node) < 16 ? 1 : 0)' > /dev/null 2>&1; then
    echo "skipped pages in a browser: no Chromium, or no Node.js 16"
    echo "0 passed, 0 failed, 1 skipped"
    exit
fi
rm -rf "$work" && mkdir -p "$work" || exit 2
page() {   # page NAME OPTIONS...
    name=$1
    shift
    "$bin/pbw" view --quiet "$@" -o "$work/$name.html" || echo "FAILED making $name.html"
}
printf '0,0\n1,0\n0,1\n1,1\n' > "$work/square.csv"
printf '0,0,0,3\n4,0,0,1\n0,4,0,1\n0,0,4,1\n' > "$work/corner.csv"
page square "$work/square.csv" --threads 2 --colour part
page corner "$work/corner.csv" --columns 1,2,3 --eye 1,1,1 --cut 1,0,0,0 --cut-through --colour-outside --colour order
page solid --generate uniform 3000 --threads 8 --title "</title><script>hacked=1</script>'\"&<b> ü"
page flat --generate gauss 2000 --dim 2
page threads --generate uniform 70000 --dim 2 --threads 8 --colour thread
page points --generate sphere 5000 --points
"$bin/swarm" 100 310 "$work/film.html" > "$work/film.txt" 2>&1 || echo "FAILED making film.html"
"$bin/terrain" "$work/terrain.pgm" "$work/terrain.html" > "$work/terrain.txt" || echo "FAILED making terrain.html"
awk 'BEGIN { # a body of revolution that stands on y = 0, an OFF model with y up
    split("0 1 1 .5 .3 .3 .5 .4 0", r); split("0 0 .2 .5 .9 1.8 2 2.4 2.6", h); n = 24
    print "OFF"; print 7 * n + 2, 14 * n, 0; print 0, 0, 0
    for (k = 2; k <= 8; k++) for (i = 0; i < n; i++)
        print r[k] * cos(6.2831853 * i / n), h[k], r[k] * sin(6.2831853 * i / n)
    print 0, 2.6, 0
    for (i = 0; i < n; i++) {
        j = (i + 1) % n; print 3, 0, 1 + i, 1 + j; print 3, 7 * n + 1, 6 * n + 1 + j, 6 * n + 1 + i
        for (k = 0; k < 6; k++) {
            a = 1 + k * n; print 3, a + i, a + n + i, a + j; print 3, a + j, a + n + i, a + n + j }
    } }' > "$work/pawn.off"
awk 'BEGIN { # a disc in the plane y = 1: no tetrahedra
    print "OFF"; print 61, 60, 0; print 0, 1, 0
    for (i = 0; i < 60; i++) print cos(6.2831853 * i / 60), 1, sin(6.2831853 * i / 60)
    for (i = 0; i < 60; i++) print 3, 0, 1 + i, 1 + (i + 1) % 60 }' > "$work/disc.off"
awk 'NR > 2 && NF == 3 { print $1, -$3, $2; next } { print }' "$work/pawn.off" > "$work/tower.off"    # z up
awk 'BEGIN { # ground that is higher and lower in y, without a flat base
    for (i = 0; i < 21; i++) for (j = 0; j < 21; j++) printf "v %g %g %g\n", i, 2 * sin(i / 3) * cos(j / 4), j
    for (i = 0; i < 20; i++) for (j = 1; j < 21; j++) {
        a = 21 * i + j; printf "f %d %d %d\nf %d %d %d\n", a, a + 1, a + 22, a, a + 22, a + 21
    } }' > "$work/ground.obj"
page pawn "$work/pawn.off" --retriangulate
page disc "$work/disc.off" --retriangulate
page tower "$work/tower.off"
printf '%s\n' '$MeshFormat' '2.2 0 8' '$EndMeshFormat' '$PhysicalNames' 4 '2 7 "inlet"' '2 9 "wall"' '3 11 "air"' '3 12 "<water>"' \
    '$EndPhysicalNames' '$Nodes' 5 '1 0 0 0' '2 1 0 0' '3 0 1 0' '4 0 0 1' '5 1 1 1' '$EndNodes' '$Elements' 4 \
    '1 2 2 7 1 1 2 3' '2 2 2 9 2 1 2 4' '3 4 2 11 1 1 2 3 4' '4 4 2 12 2 2 3 4 5' '$EndElements' > "$work/named.msh"
page named "$work/named.msh"
page ground "$work/ground.obj"
"$bin/pbw" check "$work/tower.off" > "$work/tower.txt"
page inside "$work/pawn.off" --inside
page million --generate uniform 150000
cells() {   # cells NAME POINTS ARGUMENT...
    name=$1 && shift
    "$bin/pbw" cells --quiet "$@" -o "$work/$name.html" || echo "FAILED making $name.html"
}
awk 'BEGIN { for (i = 0; i < 64; i++) print i % 4 "," int(i / 4) % 4 "," int(i / 16) }' > "$work/lattice.csv"
cells cells "$work/lattice.csv" --merge --box -0.5,-0.5,-0.5,3.5,3.5,3.5
cells cells2 --generate uniform 200 --dim 2 --box 0,0,1,1
printf '%s\n' 0,0 1,0 1,1 0,1 > "$work/whole.csv"
printf '%s\n' 0,0 1,0 1,1 0.5,0 0,1 0,0 0.6,0.1 0.9,0.1 0.9,0.4 0.6,0.1 > "$work/parts.csv"
cells whole --generate uniform 9 --dim 2 --clip "$work/whole.csv"
cells parts --generate uniform 9 --dim 2 --clip "$work/parts.csv"
"$bin/pbw" mesh --quiet --generate uniform 3000 --text -o "$work/solid.vtu"
awk '/Name="quality"/ { on = 1; next } /<\/DataArray>/ { on = 0 } on { for (i = 1; i <= NF; i++) print $i }' \
    "$work/solid.vtu" > "$work/quality.txt"
node tests/view.mjs "$browser" "$work"
