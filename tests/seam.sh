#!/bin/sh
# seam.sh FOLDER: what headers that are compiled behind another one use of its private names is what its room >>seam
# lists, and nothing more; a header behind another version, or without it, is one clear error.  Run from the root.
CC=${CC:-cc} work=${1:-build}/seam
. tests/check.sh

# The private names in the code of each header: no comments, no texts.
cat > "$work/names.awk" << 'END'
{
    code = ""
    gsub(/'\\?"'/, " ")
    for (rest = $0; rest != ""; ) {
        if (comment) {
            at = index(rest, "*/")
            comment = at == 0
            rest = comment ? "" : substr(rest, at + 2)
        } else if (match(rest, /\/[*]|\/\/|"(\\.|[^"\\])*"/)) {
            code = code substr(rest, 1, RSTART - 1) " "
            comment = substr(rest, RSTART, 2) == "/*"
            rest = substr(rest, RSTART, 2) == "//" ? "" : substr(rest, RSTART + RLENGTH)
        } else {
            code = code rest
            rest = ""
        }
    }
    count = split(code, word, /[^A-Za-z0-9_]+/)
    for (i = 1; i <= count; i++) {
        if (word[i] ~ /^(pbw|PBW)[A-Za-z0-9]*__[A-Za-z0-9_]/ && word[i] !~ /__SEAM$/ && !seen[word[i]]++) print word[i]
    }
}
END
for header in pbw.h examples/lib/*.h; do
    awk -f "$work/names.awk" "$header" | LC_ALL=C sort > "$work/$(basename "$header" .h).names"
done
# The room >>seam of a header, a line for each name and user: name, user.  Its lines have names, users, and a room.
listed() {
    awk '/^   >>[a-z]/ { inside = $1 == ">>seam" }
        inside && /^     (pbw|PBW)[A-Za-z0-9]*__/ {
            for (names = 0; $(names + 1) ~ /__/; names++) { }
            for (k = 1; k <= names; k++) for (i = names + 1; i < NF; i++) print $k, $i
        }' "$1" | LC_ALL=C sort
}
used() {        # used NAME PREFIX: the same, of what the other headers use of that one
    awk -v prefix="$(echo "$2" | tr A-Z a-z)__" -v own="$1" '
        FNR == 1 { files++; user = FILENAME; gsub(/.*\/|[.]names$/, "", user); stem = user; sub(/^pbw_/, "", stem) }
        files == 1 { if (index(tolower($0), prefix) == 1) known[$0] = 1; next }
        user != own && ($0 in known) { print $0, stem }' "$work/$1.names" "$work"/pbw_*.names | LC_ALL=C sort
}
agrees() {      # agrees NAME LIST: of the list in this file < is listed only, > is used only
    used "$1" "$(sed -n 's/^#define \(PBW[A-Z0-9]*\)__SEAM .*/\1/p' "$2")" > "$work/used"
    listed "$2" > "$work/listed"
    diff "$work/listed" "$work/used" && [ -s "$work/listed" ]
}
once() { ! listed "$1" | uniq -d | grep .; }
for header in pbw.h $(grep -l '^   >>seam' examples/lib/*.h); do
    check "$header: the list is what others use" agrees "$(basename "$header" .h)" "$header"
    check "$header: each name is listed once" once "$header"
done
# The check sees a name too few, one too many, and a user too few.
differs() { ! cmp -s pbw.h "$1" && ! agrees pbw "$1"; }
seam='/^   >>seam/,/^#define/'
sed "$seam s/ pbw__release / /" pbw.h > "$work/few.h"
sed "$seam s/ pbw__release / &pbw__for_nobody /" pbw.h > "$work/many.h"
sed "$seam { / pbw__release /s/ live / / }" pbw.h > "$work/user.h"
for change in few $([ -n "$QUICK" ] || echo many user); do
    check "a list with a name or user too few or too many is refused: $change" differs "$work/$change.h"
done

# A header that does not find its seam says so, once.
sed 's/^#define PBW__SEAM 1$/#define PBW__SEAM 2/' pbw.h > "$work/pbw.h"
sed 's/^#define PBWSF__SEAM 1$/#define PBWSF__SEAM 2/' examples/lib/pbw_surface.h > "$work/pbw_surface.h"
refuses() {     # refuses NAME ON FOLDER LINES: a file with these lines and pbw_NAME.h's implementation, which is on ON.h
    ! printf '%s\n#define PBW_%s_IMPLEMENTATION\n#include "pbw_%s.h"\n' "$4" "$(echo "$1" | tr a-z A-Z)" "$1" |
        LC_ALL=C $CC -std=c99 -I"$3" -Iexamples/lib -I. -x c -fsyntax-only - 2> "$work/refused" || return 1
    [ "$(grep -c 'error:' "$work/refused")" = 1 ] && grep "pbw_$1.h is compiled where $2.h of its version is" "$work/refused"
}
for behind in check query live; do
    check "pbw_$behind.h without PBW_IMPLEMENTATION: one clear error" refuses $behind pbw . ''
    check "pbw_$behind.h behind another version: one clear error" refuses $behind pbw "$work" '#define PBW_IMPLEMENTATION'
done
surface='#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"'
for behind in improve mesh3 adapt3 stuffing wrap; do
    check "pbw_$behind.h without PBW_SURFACE_IMPLEMENTATION: one clear error" refuses $behind pbw_surface . ''
    check "pbw_$behind.h behind another pbw_surface.h: one clear error" refuses $behind pbw_surface "$work" "$surface"
done
for behind in mesh3 adapt3; do
    check "pbw_$behind.h without PBW_IMPROVE_IMPLEMENTATION: one clear error" refuses $behind pbw_improve . "$surface"
done
finish
