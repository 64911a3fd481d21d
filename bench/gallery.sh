#!/bin/sh
# gallery.sh PROGRAM FOLDER: pages to look around in, of models of CGAL's demo data that enclose nothing (MODELS names
# others) and of five models through each other: the model with its faults, its wrap, good tetrahedra in a wrap, and
# these cut.  FOLDER/index.html lists them.
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
pages() {   # pages NAME MODEL
    page "$1-model" check "$2"
    page "$1-wrap" wrap "$2"
    page "$1-solid" solid "$2" --wrap
    page "$1-cut" solid "$2" --wrap --cut 1,0.2,0.1,0
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
for model in ${MODELS:-ALSTOM_TEST4 b9_mesh blade blobby_3cc diplodocus holes mushroom nefertiti polygon_mesh three_peaks}; do
    pages "$model" "$(path "$model")"
done
