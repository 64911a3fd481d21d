#!/bin/sh
# page.sh FOLDER: pbw_view.h and pbw_film.h hold the pages of examples/lib/view/ and film/ as they are now, and each file
# that changes would be seen.
work=${1:-build}/page
. tests/check.sh
embed() { awk -v name="pbw$kind" -f examples/lib/view/embed.awk "$1/page.html" "$header"; }
changed() {   # changed FILE: another header comes out when that file changes
    cp $page/* "$work/"
    case $1 in
    *.html) printf '<p>more</p>\n' >> "$work/$1" ;;
    *) printf '/* more */\n' >> "$work/$1" ;;
    esac
    embed "$work" > "$work/other.h" && ! cmp -s "$work/other.h" "$header"
}
up_to_date() { embed "$page" | cmp - "$header"; }
misses_file() { cp $page/* "$work/" && rm "$work/style.css" && ! embed "$work"; }
for kind in view film; do
    page=examples/lib/$kind header=examples/lib/pbw_$kind.h
    check "pbw_$kind.h is up to date (else: make page)" up_to_date
    for file in $page/*.js $page/*.css $page/*.html; do
        check "a change of $file would be seen" changed "$(basename "$file")"
        check "$file is ASCII within 118 columns" sh -c \
            "! LC_ALL=C grep -n '[^ -~]' $file && ! awk 'length > 118' $file | grep ."
    done
    check "pbw_$kind.h takes in each script and style sheet" sh -c \
        "for f in $page/*.js $page/*.css; do grep -q \"'\${f##*/}'\" $page/page.html || exit 1; done"
    check "pbw_$kind.h: a file that is missing is an error" misses_file
done
for compiler in "${CC:-cc} -std=c99" "${CXX:-c++} -std=c++11 -x c++"; do
    printf '#include "pbw.h"\n#define PBW_IO_IMPLEMENTATION\n#include "pbw_io.h"\n%s\n%s\n%s\n%s\n' \
        '#define PBW_VIEW_IMPLEMENTATION' '#include "pbw_view.h"' \
        '#define PBW_FILM_IMPLEMENTATION' '#include "pbw_film.h"' > "$work/view.c"
    check "$compiler: no warning" $compiler -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Werror \
        -I. -Iexamples/lib -fsyntax-only "$work/view.c"
done
finish
