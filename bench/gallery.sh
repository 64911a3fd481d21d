#!/bin/sh
# gallery.sh PROGRAM FOLDER: pages to look around in, of models of CGAL's demo data that enclose nothing (MODELS names
# others), of five models through each other, and of an ellipsoid scanned with holes: the model with its faults, its
# wrap, good tetrahedra in a wrap, and these cut; of shells that cross, the model and its union.  (The inner part of a
# torus through itself has the winding number 0, so it stays hollow.)  FOLDER/index.html lists them.
pbw=$(realpath "$1")
mkdir -p "$2" && folder=$(realpath "$2") || exit 2
. bench/common.sh
list_models
path() { grep "/$1\\.off\$" "$work/list" | head -n 1; }
page() {    # page NAME COMMAND MODEL OPTION...: a page, whatever the exit status is, as a model has faults
    name=$1
    shift
    timed "$pbw" "$@" -o "$folder/$name.html"
    if [ -f "$folder/$name.html" ]; then
        echo "<a href=\"$name.html\">$name</a>, $seconds s<br>" >> "$folder/index.html"
    else
        echo "$name: $(failure "$code")"
    fi
}
pages() {   # pages NAME MODEL: where the wrap is a shell, also with the alpha that closes the model
    page "$1-model" check "$2"
    page "$1-wrap" wrap "$2"
    closing=$(sed -n 's/.*; --alpha \([^ ]*\) closes it$/\1/p' "$work/report")
    page "$1-solid" solid "$2" --wrap
    page "$1-cut" solid "$2" --wrap --cut 1,0.2,0.1,0
    [ -z "$closing" ] || page "$1-closed" solid "$2" --wrap --alpha "$closing" --cut 1,0.2,0.1,0
}
: > "$folder/index.html"
first=0
for model in elephant fandisk knot1 cow 3torus; do       # each in a box of length 1, a little aside of the one before
    "$pbw" convert "$(path $model)" "$work/part.obj" > "$work/report" 2>&1 && awk -v first=$first '
        NR == FNR { if ($1 == "v") { for (k = 2; k < 5; k++) { if (!n || $k < low[k]) low[k] = $k
                                                                if (!n || $k > high[k]) high[k] = $k }; n++ }; next }
        FNR == 1 { for (k = 2; k < 5; k++) if (high[k] - low[k] > size) size = high[k] - low[k] }
        $1 == "v" { print "v", ($2 - low[2]) / size + first / 1e5, ($3 - low[3]) / size, ($4 - low[4]) / size }
        $1 == "f" { print "f", $2 + first, $3 + first, $4 + first }' "$work/part.obj" "$work/part.obj" >> "$work/soup.obj"
    first=$(grep -c '^v ' "$work/soup.obj")
done
pages soup "$work/soup.obj"

shape() {   # shape NAME: into $work/NAME.obj: boxes, cylinders across each other, spindle, a torus through itself, or scan
    awk -v name="$1" '
        function box(low, high,   i, f) {
            for (i = 0; i < 8; i++)
                print "v", (i % 2 ? high : low), (int(i / 2) % 2 ? high : low), (i > 3 ? high : low)
            split("1 3 4 2 5 6 8 7 1 2 6 5 3 7 8 4 1 5 7 3 2 4 8 6", f)
            for (i = 1; i < 25; i += 4) print "f", f[i] + count, f[i + 1] + count, f[i + 2] + count, f[i + 3] + count
            count += 8
        }
        function tube(radius, across,   i, k, u, cap) {
            for (i = 0; i < 2; i++) {
                cap = "f"
                for (k = 0; k < 48; k++) {
                    u = 2 * pi * (i ? k : -k) / 48
                    if (across) print "v", radius * cos(u), radius * sin(u), i ? 1.5 : -1.5
                    else print "v", i ? 1.5 : -1.5, radius * cos(u), radius * sin(u)
                    cap = cap " " ++count
                }
                print cap
            }
            for (k = 0; k < 48; k++)
                print "f", count - 47 + k, count - 47 - 48 + (48 - k) % 48, count - 47 - 48 + 47 - k, \
                    count - 47 + (k + 1) % 48
        }
        function turn(rows, closed,   i, k, t, u, a, b, down, away, hole) {
            for (i = 0; i < rows + !closed; i++)
                for (k = 0; k < 64; k++) {
                    t = (closed ? 2 * pi * i : 0.2 + (pi - 0.2) * 0.999 * i) / rows
                    u = 2 * pi * k / 64
                    away = closed ? 0.5 + cos(t) : sin(t) * (1 + 0.05 * sin(5 * u) * sin(4 * t))
                    print "v", away * cos(u), away * sin(u), closed ? sin(t) : 1.6 * cos(t)
                }
            for (i = 0; i < rows; i++)
                for (k = 0; k < 64; k++) {
                    hole = !closed && ((i - 14) ^ 2 + (k - 20) ^ 2 < 12 || (i - 30) ^ 2 + (k - 45) ^ 2 < 7)
                    a = i * 64 + k + 1
                    b = i * 64 + (k + 1) % 64 + 1
                    down = ((i + 1) % (rows + !closed) - i) * 64
                    if (!hole) print "f", a, a + down, b + down "\nf", a, b + down, b
                }
        }
        BEGIN {
            pi = atan2(0, -1)
            if (name == "boxes") { box(0, 1); box(0.6, 1.6) }
            if (name == "cylinders") { tube(0.5, 0); tube(0.4, 1) }
            if (name == "spindle") turn(64, 1)
            if (name == "scan") turn(48, 0)
        }' > "$work/$1.obj"
}
for model in boxes cylinders spindle; do
    shape $model
    page "$model-model" check "$work/$model.obj"
    page "$model-union" solid "$work/$model.obj"
    page "$model-cut" solid "$work/$model.obj" --cut 1,0.2,0.1,0
done
shape scan
pages scan "$work/scan.obj"
for model in ${MODELS:-ALSTOM_TEST4 b9_mesh blade blobby_3cc diplodocus holes mushroom nefertiti polygon_mesh three_peaks}; do
    pages "$model" "$(path "$model")"
done
