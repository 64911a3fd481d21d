#!/bin/sh
# interface.sh FOLDER: the public declarations of pbw.h and of each companion header, without comments, have the sums
# that tests/interface.txt has for this version.  A change of them gets a line in the history: of pbw.h in >>history, of
# companions in examples/lib/HISTORY.md.  Then `make interface` (interface.sh --update) writes the new sums; for a
# version that has a tag it refuses, until the titles, the PBW_VERSION_ macros and the history have the next one.
list=tests/interface.txt
title=$(sed -n '1s/.* - v\([0-9.]*\) - .*/\1/p' pbw.h)

declarations() {    # declarations HEADER: what comes before the implementation, without comments and bodies
    awk '/^#endif *\/\* PBW[A-Z0-9_]*_H \*\// { exit }
         /^{/ { body = 1 }
         body { if (/^}/) body = 0; next }
         /^# *define PBW_VERSION/ { next }
         { text = text $0 "\n" }
         END {
             while ((at = index(text, "/*")) > 0) {
                 rest = substr(text, at + 2)
                 text = substr(text, 1, at - 1) " " substr(rest, index(rest, "*/") + 2)
             }
             gsub(/\/\/[^\n]*/, "", text); gsub(/[ \t\n]+/, " ", text); print text
         }' "$1"
}
sums() {
    echo "version $title"
    for header in pbw.h examples/lib/*.h; do
        echo "$(basename "$header") $(declarations "$header" | cksum)"
    done
}
if [ "$1" = --update ]; then
    if sums | cmp -s - $list; then
        echo "nothing has changed"
    elif [ "$(sed -n 's/^version //p' $list 2> /dev/null)" = "$title" ] &&
        git rev-parse -q --verify "refs/tags/v$title" > /dev/null; then
        echo "v$title has been released: first raise the version, in the titles, the macros and the history" >&2
        exit 1
    else
        sums > $list
        echo "$list: written"
    fi
    exit
fi

work=${1:-build}/interface
. tests/check.sh
sums > "$work/sums"
recorded() {
    diff $list "$work/sums" && return
    echo "the version or public declarations changed: write into the history what did, then \`make interface\`"
    return 1
}
check "the public declarations are those of version $title" recorded
enough() { [ "$(grep -c ' [1-9][0-9]* [1-9][0-9]*$' "$work/sums")" = "$(ls pbw.h examples/lib/*.h | wc -l)" ]; }
check "each header has declarations" enough
check "the history of the companions has version $title" grep -qx "## $title" examples/lib/HISTORY.md
web=$(sed -n 's/.*"version": "\([0-9.]*\)".*/\1/p' examples/web/package.json)
check "examples/web/package.json: $web" [ "$web" = "$title" ]
for header in examples/lib/*.h; do
    check "$header: the version in its title" grep -q "^/\* pbw_[a-z0-9]*\.h - v$title - " "$header"
done

# The sum sees a new member and another type, but no comment.
cp examples/lib/pbw_surface.h "$work/header.h"
before=$(declarations "$work/header.h" | cksum)
changed() { # changed SCRIPT: whether the header that sed makes by it has another sum
    sed "$1" examples/lib/pbw_surface.h > "$work/header.h"
    ! cmp -s examples/lib/pbw_surface.h "$work/header.h" &&
        [ "$(declarations "$work/header.h" | cksum)" != "$before" ]
}
unchanged() {
    ! changed "$1" && ! cmp -s examples/lib/pbw_surface.h "$work/header.h"
}
check "another type changes the sum" changed '20,/_H \*\//s/size_t/unsigned/'
check "another member changes the sum" changed 's,^    void \*memory;,    int more;&,'
check "another comment does not" unchanged '1,/\*\//s/ the / a /'
finish
