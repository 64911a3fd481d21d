#!/bin/sh
# page.sh FOLDER: pbw_view.h holds the page of examples/lib/view/ as it is now, and notices each file that changes.
work=${1:-build}/page
. tests/check.sh
page=examples/lib/view header=examples/lib/pbw_view.h
embed() { awk -f "$1/embed.awk" "$1/page.html" $header; }
changed() {   # changed FILE: another header comes out when that file changes
    cp $page/* "$work/"
    case $1 in
    *.html) printf '<p>more</p>\n' >> "$work/$1" ;;
    *) printf '/* more */\n' >> "$work/$1" ;;
    esac
    embed "$work" > "$work/other.h" && ! cmp -s "$work/other.h" $header
}
check "pbw_view.h is up to date (else: make page)" sh -c "awk -f $page/embed.awk $page/page.html $header | cmp - $header"
for file in $page/*.js $page/*.css $page/*.html; do
    check "a change of $file would be seen" changed "$(basename "$file")"
    check "$file is ASCII within 118 columns" sh -c "! LC_ALL=C grep -n '[^ -~]' $file && ! awk 'length > 118' $file | grep ."
done
check "the page takes in each script and style sheet" sh -c \
    "for f in $page/*.js $page/*.css; do grep -q \"'\${f##*/}'\" $page/page.html || exit 1; done"
check "a file that is missing is an error" sh -c \
    "cp $page/* $work/ && rm $work/data.js && ! awk -f $work/embed.awk $work/page.html $header"
for compiler in "${CC:-cc} -std=c99" "${CXX:-c++} -std=c++11 -x c++"; do
    printf '#include "pbw.h"\n#define PBW_IO_IMPLEMENTATION\n#include "pbw_io.h"\n%s\n%s\n' \
        '#define PBW_VIEW_IMPLEMENTATION' '#include "pbw_view.h"' > "$work/view.c"
    check "$compiler: no warning" $compiler -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Werror \
        -I. -Iexamples/lib -fsyntax-only "$work/view.c"
done
finish
