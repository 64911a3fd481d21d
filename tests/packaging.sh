#!/bin/sh
# packaging.sh FOLDER: what a user of pbw.h relies on before calling it: compilers and standards without a warning,
# names, copies, contents list, versions, the programs in the documentation.  Run from the root, with libpbw.o in FOLDER;
# CC, CXX as in the Makefile.
CC=${CC:-cc} CXX=${CXX:-c++} library=${1:-build}/libpbw.o work=${1:-build}/packaging
warn="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Werror"
. tests/check.sh
same() { diff "$1" "$2" && [ -s "$1" ]; }
declines() {   # declines COMPILER FLAGS...: does not compile and says why, or answers PBW_ERROR_FP_MODE
    if "$@" -I. "$work/mode.c" -o "$work/mode" -lpthread 2> "$work/refused"; then
        "$work/mode"
    else
        grep 'exact only w[hi]' "$work/refused"
    fi
}

# alone: pbw.h; proof, query, live: with one of the headers that are compiled behind it; whole: with all, as the library.
printf '#include "%s"\n' pbw.h examples/lib/pbw_check.h examples/lib/pbw_query.h examples/lib/pbw_live.h > "$work/interface.c"
printf '#define PBW_IMPLEMENTATION\n#include "pbw.h"\n' > "$work/alone.c"
printf '#define PBW_CHECK_IMPLEMENTATION\n#include "examples/lib/pbw_check.h"\n' | cat "$work/alone.c" - > "$work/proof.c"
printf '#define PBW_QUERY_IMPLEMENTATION\n#include "examples/lib/pbw_query.h"\n' | cat "$work/alone.c" - > "$work/query.c"
printf '#define PBW_LIVE_IMPLEMENTATION\n#include "examples/lib/pbw_live.h"\n' | cat "$work/alone.c" - > "$work/live.c"
printf '#define PBW_LIVE_IMPLEMENTATION\n#include "examples/lib/pbw_live.h"\n' | cat "$work/query.c" - > "$work/whole.c"
printf '#define PBW_CHECK_IMPLEMENTATION\n#include "examples/lib/pbw_check.h"\n' >> "$work/whole.c"
cat > "$work/static.c" << 'END'
#define PBW_STATIC
#define PBW_CHECK_IMPLEMENTATION
#define PBW_QUERY_IMPLEMENTATION
#define PBW_LIVE_IMPLEMENTATION
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include "pbw.h"
#include "examples/lib/pbw_check.h"
#include "examples/lib/pbw_query.h"
#include "examples/lib/pbw_live.h"
#include "examples/lib/pbw_check.h"
#include "examples/lib/pbw_query.h"
#include "examples/lib/pbw_live.h"
#define PBW_IMPLEMENTATION
#include "pbw.h"
unsigned long COPY(void);
unsigned long COPY(void)
{
    static const double points[15] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1 };
    pbw_mesh mesh;
    pbw_status status = pbw_triangulate(3, points, NULL, 5, NULL, &mesh);
    unsigned long count = (unsigned long)mesh.simplex_count;
    pbw_free(&mesh);
    return status == PBW_OK ? count : 0;
}
END
printf '#include "pbw.h"\nunsigned long f(void);\nint main(void) { return !(f() == 2 && pbw_version() == PBW_VERSION); }\n' \
    > "$work/copies.c"
printf '#include "pbw.h"\nint main() { return pbw_version() != PBW_VERSION || *pbw_status_string(PBW_OK) == 0; }\n' \
    > "$work/caller.c"
printf 'int main(int n, char **v) { return 1 / (v[0][0] + 0.5 * n) == 0; }\n' > "$work/double.c"
cat > "$work/mode.c" << 'END'
#define PBW_STATIC
#define PBW_NO_SIMD
#define PBW_IMPLEMENTATION
#include "pbw.h"
int main(void)
{
    static const double points[12] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1 };
    pbw_mesh mesh;
    pbw_status status = pbw_triangulate(3, points, NULL, 4, NULL, &mesh);
    pbw_free(&mesh);
    return status != PBW_ERROR_FP_MODE;
}
END
cp "$work/interface.c" "$work/interface.cpp"
cp "$work/whole.c" "$work/whole.cpp"
cp "$work/static.c" "$work/static.cpp"
cp "$work/caller.c" "$work/caller.cpp"

# Compilers and standards: no warning, of the interface alone and with everything.  With QUICK one compiler, the oldest
# C, the newest C++, and two flags that break arithmetic.
long=1
[ -z "$QUICK" ] || long=
compilers=
for compiler in "$CC" ${QUICK:-gcc clang}; do
    [ "$compiler" = 1 ] && continue
    case " $compilers " in *" $compiler "*) continue ;; esac
    if command -v "${compiler%% *}" > /dev/null; then
        compilers="$compilers $compiler"
    else
        skip "$compiler: not installed"
    fi
done
for compiler in $compilers; do
    case $compiler in
    gcc) plus=g++ ;;
    clang) plus=clang++ ;;
    *) plus=$CXX ;;
    esac
    for file in interface whole static; do
        for std in c99 ${long:+c11}; do
            [ $file$std != staticc11 ] || continue
            check "$compiler -std=$std: $file" $compiler -std=$std $warn -I. -DCOPY=f -fsyntax-only "$work/$file.c"
        done
        for std in ${long:+c++11} c++17; do
            case $QUICK$file$std in 1whole* | staticc++11) continue ;; esac
            if command -v "${plus%% *}" > /dev/null; then
                check "$plus -std=$std: $file" $plus -std=$std $warn -I. -DCOPY=f -fsyntax-only "$work/$file.cpp"
            else
                skip "$plus: not installed"
            fi
        done
    done
    for clocks in 0 1; do
        in_full "$compiler: bench.c, with clocks: $clocks" $compiler -std=c99 $warn $([ $clocks = 0 ] || echo -DBENCH_CLOCKS) \
            -I. -Iexamples/lib -fsyntax-only bench/bench.c
    done
    in_full "$compiler: PBW_WIDE" $compiler -std=c99 $warn -I. -DPBW_WIDE -fsyntax-only "$work/whole.c"
    for file in alone ${long:+proof query live}; do
        check "$compiler: $file" $compiler -std=c99 $warn -I. -fsyntax-only "$work/$file.c"
    done
    for flags in -ffast-math -funsafe-math-optimizations ${long:+-mfpmath=387 -Ofast -freciprocal-math} \
        ${long:+-fno-signed-zeros -ffinite-math-only -fsingle-precision-constant} \
        ${long:+"-fassociative-math -fno-signed-zeros -fno-trapping-math"}; do
        if $compiler -O2 $flags -Werror "$work/double.c" -o "$work/double" 2> /dev/null; then    # it has the flag
            check "$compiler: $flags is refused" declines $compiler -O1 $flags
        fi
    done
done

# What strangers trip over.
refuses() {   # refuses TEXT COMMAND...: it fails, with one error, of this text
    text=$1
    shift
    ! LC_ALL=C "$@" > "$work/refused" 2>&1 && [ "$(grep -c 'error:' "$work/refused")" = 1 ] &&
        grep -q -e "$text" "$work/refused"
}
cat > "$work/first.cpp" << 'END'
#include "pbw.h"
pbw_mesh empty(void);
pbw_mesh empty(void) { pbw_mesh mesh = {}; return mesh; }
bool is_none(pbw_index i);
bool is_none(pbw_index i) { return i == PBW_NONE; }
END
cat "$work/whole.c" - > "$work/fused.c" << 'END'
double fused(double a, double b, double c);
double fused(double a, double b, double c) { return a * b + c; }
END
for compiler in $compilers; do
    case $compiler in
    gcc) plus=g++ ;;
    clang) plus=clang++ ;;
    *) plus=$CXX ;;
    esac
    for std in c89 gnu89; do
        check "$compiler -std=$std: one clear error" refuses 'C99 or later' \
            $compiler -std=$std -I. -c "$work/alone.c" -o "$work/c89.o"
        check "$compiler -std=$std: the interface" $compiler -std=$std -Wall -I. -fsyntax-only "$work/interface.c"
    done
    if command -v "${plus%% *}" > /dev/null; then
        check "$plus: mesh = {} and PBW_NONE" $plus -std=c++11 $warn -Wold-style-cast -I. -fsyntax-only \
            "$work/first.cpp"
    fi
    if $compiler -mfpmath=387 -Werror -c "$work/double.c" -o "$work/x87.o" 2> /dev/null; then
        check "$compiler: x87 arithmetic is a compile error" refuses '-msse2 -mfpmath=sse' \
            $compiler -std=c99 -mfpmath=387 -I. -c "$work/alone.c" -o "$work/x87.o"
    fi
    # Contraction is the user's again after the implementation, with a compiler that turns it off by a pragma.
    case "$(uname -m) $($compiler --version)" in
    *x86_64*clang*)
        if command -v objdump > /dev/null; then
            $compiler -std=gnu99 -O0 -DPBW_STATIC -mfma -ffp-contract=on -I. -c "$work/fused.c" \
                -o "$work/fused.o"
            objdump -d "$work/fused.o" | sed -n '/<fused>:/,/ret/p' > "$work/fused"
            check "$compiler: contracts the code after the implementation" grep -q vfmadd "$work/fused"
        fi ;;
    esac
done

# Copies and callers.
check "a PBW_STATIC copy compiles" $CC -O1 -I. -DCOPY=f -c "$work/static.c" -o "$work/f.o"
check "it links to one program with the library" $CC -I. "$work/copies.c" "$work/f.o" "$library" -o "$work/copies" -lpthread
check "both work" "$work/copies"
case $(uname -m) in
x86_64) check "vectors are compiled on this machine" sh -c \
    "$CC -E -dM -I. $work/whole.c | grep '^#define PBW__AVX2' > /dev/null" ;;
esac
check "C++ calls C: compiles" $CXX -I. -c "$work/caller.cpp" -o "$work/caller.o"
check "C++ calls C: links" $CXX "$work/caller.o" "$library" -o "$work/caller" -lpthread
check "versions of header and implementation agree" "$work/caller"
if command -v nm > /dev/null; then
    nm -g "$library" | awk 'NF == 3 { print $3 }' | sed 's/^_//' > "$work/exported"
    check "exports pbw_ names only" sh -c "! grep -v '^pbw_[a-z]' $work/exported && [ -s $work/exported ]"
    nm -g "$work/f.o" | awk 'NF == 3 { print $3 }' | sed 's/^_//' > "$work/exported"
    check "PBW_STATIC exports nothing" [ "$(cat "$work/exported")" = f ]
    check "no writable globals" sh -c "! nm $library | grep -E ' [bBcCgGsS] ' && size -A $library |
        awk '\$1 ~ /^[.]t?(data|bss)\$/ { bytes += \$2; found = 1 } END { exit !found || bytes > 0 }'"
else
    skip "exported names: no nm"
fi

# Macros: only PBW_ ones are left behind.
sed -n 's/^ *# *include <\(.*\)>.*/\1/p' pbw.h | sort -u | while read -r header; do
    printf '#include <%s>\n' "$header" > "$work/header.c"      # those of this machine
    $CC -E "$work/header.c" > /dev/null 2>&1 && cat "$work/header.c"
done > "$work/system.c"
for file in interface whole; do
    $CC -dM -E "$work/system.c" | sort > "$work/before" 2> /dev/null
    cat "$work/system.c" "$work/$file.c" > "$work/both.c"
    $CC -I. -dM -E "$work/both.c" | sort > "$work/after"
    check "defines only PBW macros: $file" sh -c \
        "comm -13 $work/before $work/after > $work/new && [ -s $work/new ] && ! grep -v '^#define PBW' $work/new"
done

# Text: contents and rooms, versions, the quick start.
# Rooms: each begins with a banner, which has its >>tag and tells what comes In, goes Out or always Holds (but for
# >>interface, >>history, >>license), and has 700 lines at most; the contents list at the top names them in order.  A
# file whose rooms have tags is added to one of these lists and stays there.
rooms="pbw.h examples/lib/pbw_check.h examples/lib/pbw_query.h examples/lib/pbw_live.h pbw_cuda.cu"
rooms_of_companions="examples/lib/pbw_film.h examples/lib/pbw_generate.h examples/lib/pbw_io.h examples/lib/pbw_model.h
    examples/lib/pbw_picture.h examples/lib/pbw_sample.h examples/lib/pbw_view.h
    examples/lib/pbw_adapt3.h examples/lib/pbw_improve.h examples/lib/pbw_mesh3.h examples/lib/pbw_stuffing.h
    examples/lib/pbw_fill.h examples/lib/pbw_wrap.h
    examples/lib/pbw_cells.h examples/lib/pbw_mesh2.h examples/lib/pbw_adapt2.h
    examples/lib/pbw_surface.h examples/lib/pbw_mpi.h examples/lib/pbw_tilefile.h examples/lib/pbw_tiles.h"
cat > "$work/rooms.awk" << 'END'
function leave() {
    if (name == "") return
    if (FNR - start > 700) print FILENAME ": " name ": " FNR - start " lines"
    if (!(in_ && out) && !holds && name !~ /^>>(interface|history|license)$/)
        print FILENAME ": " name ": neither In and Out nor Holds"
}
/^     >>[a-z0-9]+ / && !rooms { contents[++listed] = $1 }
/^   >>[a-z0-9]+( |$)/ {
    leave()
    if ($1 != contents[++rooms] && !wrong++)
        print FILENAME ":" FNR ": " $1 " is where the contents have " contents[rooms]
    name = $1; start = FNR; in_ = out = holds = 0; banner = 1
}
banner && /(^   |[.]  )In:( |$)/ { in_ = 1 }
banner && /(^   |[.]  )Out:( |$)/ { out = 1 }
banner && /(^   |[.]  )Holds[:, ]/ { holds = 1 }
/\*\/$/ { banner = 0 }
END {
    leave()
    if (rooms < 3 || rooms != listed) print FILENAME ": " rooms + 0 " rooms, " listed + 0 " in the contents"
}
END
for file in $rooms $rooms_of_companions; do
    check "rooms of $file: contents, sizes, In, Out, Holds" sh -c "! awk -f $work/rooms.awk $file | grep ."
done
# The index at the top of each header has its functions, in the order of their declarations, one line each.
cat > "$work/declared.awk" << 'END'
/^#if.*IMPLEMENT/ { exit }
/^((PBW__DEVICE )?PBW[A-Z0-9]*DEF|PBW_INLINE|PBW__HOST_INLINE|extern) [^(]*\(/ { sub(/\(.*/, ""); sub(/.*[ *]/, ""); if (!/__/) print }
END
for file in pbw.h examples/lib/*.h; do
    awk -f "$work/declared.awk" "$file" > "$work/declared"
    [ -s "$work/declared" ] || continue             # all its functions are static
    awk '/^   FUNCTIONS$/ { inside = 1; next }
        NF == 0 { inside = 0 }
        /\*\// { exit }
        inside { print (NF > 1 ? $1 : $1 " has no description") }' "$file" > "$work/indexed"
    check "the index of $file names its functions, in order" same "$work/declared" "$work/indexed"
done
title=$(sed -n '1s/.* - v\([0-9.]*\) - .*/\1/p' pbw.h)
macros=$(sed -n 's/^#define PBW_VERSION_[MP][A-Z]* \([0-9]*\)$/\1/p' pbw.h | paste -s -d . -)
history=$(sed -n '/^   >>history/,/^   >>license/s/^   \([0-9][0-9.]*\)  .*/\1/p' pbw.h | head -n 1)
check "versions agree: title $title, macros $macros, history $history" \
    [ "$title,$macros,$history" = "$title,$title,$title" ]
tag=$(git describe --tags --exact-match 2> /dev/null)
if [ -n "$tag" ]; then
    check "the tag $tag is the version" [ "$tag" = "v$title" ]
fi
for file in pbw.h examples/lib/pbw_check.h examples/lib/pbw_query.h examples/lib/pbw_live.h; do
    check "$file includes no stdio.h, and never prints, exits or aborts" sh -c \
        "! sed '1,/^\*\//d' $file | grep -nE '# *include <stdio|\\<(printf|puts|exit|abort|assert|longjmp)\\> *\\('"
done
# (Lines of the help of commands, and of pages inside headers, are what they print.)
check "no line of the headers, the program, the examples and the Python package is over 118 columns" sh -c \
    "! LC_ALL=C awk 'length > 118 && !/^ *\".*\",?\$/ { print FILENAME, FNR }' pbw.h pbw_cuda.cu examples/*.[ch]* \
        examples/*/*.[ch] examples/python/*.py examples/python/pbw/*.py bench/*.cpp | grep ."
# Functions stay small.  A function starts in column 1, in pbw_cuda.cu perhaps with its template parameters,
# and ends with a } there; names of the interface are exempt from the limit of parameters.
cat > "$work/functions.awk" << 'END'
/^template [^(]*>$/ { template = FNR; next }
/^[A-Za-z_].*\(/ && !/;$/ && !/^(typedef|struct|enum|extern [^"])/ {
    if (/^__global__/ || !waits) start = template > 0 && template == FNR - 1 ? template : FNR
    head = $0; waits = 1; template = 0; next
}
waits && /^{/ {
    waits = 0; inside = 1
    gsub(/__launch_bounds__\(([^()]|\([^()]*\))*\)/, "", head)
    while (gsub(/<[^<>]*>/, "", head)) { }
    name = head; sub(/\(.*/, "", name); sub(/.*[ *&]/, "", name)
    list = head; sub(/^[^(]*pbw[a-z0-9]*_[a-z0-9_]*\(/, "", list)
    if (FILENAME ~ /\.cu$/) sub(/^[^(]*\(/, "", list)
    gsub(/\([^()]*\)/, "", list); parameters = gsub(/,/, "", list) + 1; next
}
waits { if (/;$/) waits = 0; else head = head $0; next }
inside && /^}/ {
    inside = 0; functions++
    if (FNR - start + 1 > 70 || (parameters > 6 && name !~ /^pbw[a-z0-9]*_[a-z]/))
        print FILENAME ": " name ": " FNR - start + 1 " lines, " parameters " parameters"
}
END { if (functions < 300) print "only " functions + 0 " functions were found" }
END
check "no product is split by fma, which some libraries round twice" sh -c \
    "! grep -nE '(^|[^_[:alnum:]])fmaf?\(' examples/lib/*.h examples/program/*.[ch] | grep ."
check "no example is over 150 lines" sh -c "! wc -l examples/*.c* examples/[!lp]*/*.c* examples/python/*.c |
    awk '\$1 > 150 && \$2 != \"total\"' | grep ."
gallery() {     # every example is in examples/README.md, and what that and README.md show is there
    for file in examples/*.c examples/*.cpp examples/*.cu; do
        grep -qF "($(basename "$file"))" examples/README.md || { echo "$file"; return 1; }
    done
    for file in $(grep -o 'pictures/[a-z-]*\.png' examples/README.md README.md | sed 's/.*://' | sort -u); do
        [ -f "examples/$file" ] || { echo "$file"; return 1; }
    done
}
check "the gallery has all examples, and all pictures are there" gallery
check "no function is over 70 lines or has more than 6 parameters" sh -c \
    "! awk -f $work/functions.awk pbw.h examples/lib/*.h pbw_cuda.cu | grep ."
promised() {    # promised HEADER: the tests that its promises name are there
    sed -n '/PROMISES/,/^   C/s/.* \(tests\/[a-z_.]*\)$/\1/p' "$1" > "$work/promised"
    [ -s "$work/promised" ] && ls $(cat "$work/promised")
}
shared="-DPBW__IMPLEMENTED -DPBWCK__IMPLEMENTED -DPBWQ__IMPLEMENTED -DPBWL__IMPLEMENTED"     # as the library has them
quick() {       # quick HEADER PRINTED: its quick start compiles, as C++ without a warning, and prints this
    inside=                                     # the implementation; with QUICK that of pbw.h alone
    [ -z "$QUICK" ] || [ "$1" = pbw.h ] || inside=$shared
    sed -n '/^   QUICK START/,/^   Build:/s/^       //p' "$1" > "$work/quickstart.c"
    $CC $inside -I. -Iexamples/lib -fsyntax-only "$work/quickstart.c" &&
        $CC $shared -I. -Iexamples/lib "$work/quickstart.c" "$library" -o "$work/quickstart" -lpthread &&
        $CXX $inside -x c++ -Wall -Wextra -Wpedantic -Werror -I. -Iexamples/lib -fsyntax-only "$work/quickstart.c" &&
        "$work/quickstart" > "$work/printed" && echo "$2" | diff "$work/printed" -
}
for header in examples/lib/pbw_check.h examples/lib/pbw_query.h examples/lib/pbw_live.h pbw.h; do
    check "every promise of $header names a test that is there" promised "$header"
    case $header in
    pbw.h) printed='0 2 3 1
2 3 1 4' ;;
    *check.h) printed='right: 8 facets' ;;
    *query.h) printed='in triangle 3, nearest to point 1
in triangle 2, nearest to point 4' ;;
    *) printed='point 4, 4 triangles' ;;
    esac
    check "the quick start of $header" quick "$header" "$printed"
done
if [ -f README.md ]; then
    awk '/^```c$/ { inside = 1; text = ""; next }
         /^```/ && inside { inside = 0; if (text ~ /int main/) { printf "%s", text; exit } }
         inside { text = text $0 "\n" }' README.md > "$work/readme.c"
    check "README: its first program has the implementation" sh -c \
        "$CC -I. -fsyntax-only $work/readme.c && $CC -I. -E $work/readme.c | grep 'uint64_t pbw_hash(.*)\$'"
    in_full "README: its first program as C++, without a warning" "${CXX:-c++}" -x c++ -O1 -Wall -Wextra -Wpedantic -Werror \
        -I. -fsyntax-only "$work/readme.c"
    check "README: its first program compiles" $CC -O1 -I. -DPBW__IMPLEMENTED "$work/readme.c" "$library" \
        -o "$work/readme" -lpthread -lm
    check "README: its first program runs" "$work/readme"
else
    skip "README: there is none"
fi
# The example at the top of each companion header, within a main of a program that declares what it is given.
example() { # example HEADER DECLARATIONS
    {
        [ "$1" != pbw_stuffing.h ] || echo '#define PBW_SURFACE_IMPLEMENTATION'
        printf '#include <%s>\n' math.h stdio.h stdlib.h
        printf '#include "%s"\n%s\nint main(void)\n{\n' "$1" "$2"
        awk '/^ *\*\// || (inside && /^   [^ ]/) { exit } /^       / { inside = 1 }
             inside && !/^       #/ { print substr($0, 8) }' "examples/lib/$1"
        printf 'return 0;\n}\n'
    } > "$work/top.c"
    grep -q ';$' "$work/top.c" || return 1
    set -- "${CC:-cc} -std=c99" "${CXX:-c++} -std=c++11 -x c++" "$1"
    [ "$3" != pbw_mpi.h ] || set -- "mpicc -std=c99"
    for language in "$1" "${2:-none}"; do
        command -v "${language%% *}" > /dev/null || continue
        $language -Wall -Wno-unused -Werror -I. -Iexamples/lib -fsyntax-only "$work/top.c" || return 1
    done
}
numbers='static const double *points; static size_t n, m; static const pbw_index *triangles;'
fields='static double *error, *values, *new_values;'
for header in examples/lib/*.h; do
    header=$(basename "$header")
    given=
    case $header in
    pbw_adapt2.h) given="static pbw_plane plane; $fields" ;;
    pbw_adapt3.h) given="static pbw_tets mesh; $fields" ;;
    pbw_cells.h) given='static const double *points; static size_t count;' ;;
    pbw_film.h) given='static int next(void *u, pbwfilm_frame *frame) { return u != frame; } static void *user;' ;;
    pbw_improve.h) given="$numbers static const pbw_index *corners;" ;;
    pbw_fill.h | pbw_mesh3.h | pbw_sample.h | pbw_wrap.h) given=$numbers ;;
    pbw_picture.h | pbw_view.h) given='static pbw_mesh mesh; static pbwio_error error;' ;;
    pbw_stuffing.h) given='static double function(const double p[3]) { return 1 - p[0] * p[0]; }' ;;
    pbw_surface.h) given="$numbers static size_t point_count, triangle_count; static double p[3];" ;;
    pbw_tiles.h) given='static pbwt_point *sample, *points; static size_t samples, count; static int dim, parts, p, r;
        static pbwt_cut *cuts; static pbwt_tree tree, its_tree; static pbwt_summary summary, *summaries;
        static pbwt_options options; static pbwt_tile tile; static pbwt_served *its_served; static int more;
        static pbwt_bytes reply;' ;;
    pbw_mpi.h)
        command -v mpicc > /dev/null || { skip "pbw_mpi.h: no mpicc"; continue; }
        given='static const pbwt_point *points; static size_t count;' ;;
    esac
    case $header in pbw_check.h | pbw_query.h | pbw_live.h) continue ;; esac      # a whole program, see above
    check "$header: the example at its top compiles" example "$header" "$given"
done
check "the root holds nothing that should be elsewhere" sh -c \
    "! ls | grep -vxE 'pbw\\.h|pbw_cuda\\.cu|examples|tests|bench|Makefile|README\\.md|build'"

[ -z "$QUICK" ] || finish

# Other machines, where their compilers and libraries are installed.
printf '#include <stdlib.h>\nint main(void) { return 0; }\n' > "$work/empty.c"
for other in "$CC -m32 -msse2 -mfpmath=sse" aarch64-linux-gnu-gcc arm-linux-gnueabihf-gcc s390x-linux-gnu-gcc \
    x86_64-w64-mingw32-gcc; do
    if $other "$work/empty.c" -o "$work/empty" > /dev/null 2>&1; then
        # Tests below link two of the objects; of the others the compiler's warnings are wanted.
        kind=-fsyntax-only level=-O1
        case $other in
        *m32*) kind=-c ;;
        *mingw32*) kind=-c ;;
        esac
        check "$other: no warning" $other -std=c99 $level $warn -I. $kind "$work/whole.c" \
            -o "$work/$(basename "${other%% *}").o"
    else
        skip "$other: not installed"
    fi
done

# Windows: with and without threads, before and after windows.h; and where there is wine, a test runs.  (Compiled with
# -Os, at which gcc once kept values where calls clear them.)
printf '#include <windows.h>\n%s\nFARPROC last;\n' "$(cat "$work/whole.c")" > "$work/before.c"
printf '%s\nextern int near, far, small, min;\n#include <winsock2.h>\n#include <windows.h>\nFARPROC last;\n' \
    "$(cat "$work/whole.c")" > "$work/after.c"
for file in empty before after; do
    cp "$work/$file.c" "$work/$file.cpp"
done
other=x86_64-w64-mingw32
for compiler in "$other-gcc -std=c99" "$other-g++ -std=c++11" "clang --target=$other -std=c99"; do
    case $compiler in
    *++*) kind=cpp ;;
    *) kind=c ;;
    esac
    if $compiler -fsyntax-only "$work/empty.$kind" > /dev/null 2>&1; then
        for flags in "" -DPBW_NO_THREADS; do
            for file in $([ -n "$flags" ] || echo before) after; do
                # shellcheck disable=SC2086
                check "$compiler $flags: windows.h $file" $compiler $flags $warn -I. -fsyntax-only "$work/$file.$kind"
            done
        done
    else
        skip "$compiler: not installed"
    fi
done
if $other-gcc "$work/empty.c" -o "$work/empty" > /dev/null 2>&1; then
    check "$other: the pbw program" $other-gcc -std=c99 -O0 -DPBW__IMPLEMENTED -DPBWCK__IMPLEMENTED \
        -DPBWQ__IMPLEMENTED -DPBWL__IMPLEMENTED -I. -Iexamples/lib examples/program/*.c "$work/$other-gcc.o" -o "$work/pbw.exe"
    for part in library library_solid library_files library_plane library_fill; do
        cat examples/program/$part.c
    done | sed '1i #include <windows.h>' > "$work/companions.c"
    check "$other: all companions after windows.h" $other-gcc -std=c99 -I. -Iexamples/lib -fsyntax-only "$work/companions.c"
    if command -v wine > /dev/null; then
        check "$other: the implementation compiles" $other-gcc -std=c99 -Os -I. -c "$work/whole.c" -o "$work/other.o"
        check "$other: a test compiles" \
            $other-gcc -std=c99 -Os -I. -Iexamples/lib tests/test_answer.c "$work/other.o" -o "$work/answer.exe"
        export WINEPREFIX="$(cd "$work" && pwd)/wine" WINEDEBUG=-all
        check "$other: the test passes" timeout 600 \
            wine "$work/answer.exe" --filter collinear --filter "threads: 2D uniform" --filter "threads: 3D sphere"
        wineserver -k -w
        rm -rf "$WINEPREFIX"                            # 700 MB
    else
        skip "$other: the test: no wine"
    fi
fi
# MSVC: clang takes its place, without what MSVC does not define, with declarations of what the header calls.  The
# object file is good for mingw's linker, so where there is wine a test runs with MSVC's threads and atomics.
msvc="clang --target=x86_64-pc-windows-msvc -ffreestanding -U__SSE2__ -U__amd64 -U__amd64__ -U__x86_64 -U__x86_64__"
if clang --target=x86_64-pc-windows-msvc -ffreestanding -fsyntax-only -x c /dev/null 2> /dev/null; then
    mkdir -p "$work/msvc"
    cat > "$work/msvc/stdlib.h" << 'END'
#include <stddef.h>
void *malloc(size_t), *realloc(void *, size_t), free(void *);
void qsort(void *, size_t, size_t, int (*)(const void *, const void *));
void *bsearch(const void *, const void *, size_t, size_t, int (*)(const void *, const void *));
END
    cat > "$work/msvc/string.h" << 'END'
#include <stddef.h>
void *memcpy(void *, const void *, size_t), *memmove(void *, const void *, size_t), *memset(void *, int, size_t);
int memcmp(const void *, const void *, size_t);
size_t strlen(const char *);
END
    cat > "$work/msvc/math.h" << 'END'
#define HUGE_VAL (__builtin_huge_val())
double sqrt(double), floor(double), fabs(double), ceil(double), frexp(double, int *), ldexp(double, int);
double pow(double, double), cbrt(double), fmax(double, double), fmod(double, double);
END
    cat > "$work/msvc/process.h" << 'END'
unsigned __int64 _beginthreadex(void *, unsigned, unsigned (__stdcall *)(void *), void *, unsigned, unsigned *);
END
    cat > "$work/msvc/intrin.h" << 'END'
void _ReadWriteBarrier(void);
char _InterlockedCompareExchange8(char volatile *, char, char);
long _InterlockedCompareExchange(long volatile *, long, long), _InterlockedExchange(long volatile *, long);
long _InterlockedExchangeAdd(long volatile *, long);
__int64 _InterlockedCompareExchange64(__int64 volatile *, __int64, __int64);
__int64 _InterlockedExchangeAdd64(__int64 volatile *, __int64);
END
    cat > "$work/msvc/windows.h" << 'END'
#define _WINDOWS_
#define near
#define far
#define small char
typedef void *HANDLE;
typedef unsigned long DWORD;
typedef struct _RTL_SRWLOCK { void *Ptr; } SRWLOCK, *PSRWLOCK;
typedef struct _RTL_CONDITION_VARIABLE { void *Ptr; } CONDITION_VARIABLE, *PCONDITION_VARIABLE;
typedef union _LARGE_INTEGER { __int64 QuadPart; } LARGE_INTEGER;
#define WINAPI(result) __declspec(dllimport) result __stdcall
WINAPI(int) QueryPerformanceCounter(LARGE_INTEGER *);
WINAPI(int) QueryPerformanceFrequency(LARGE_INTEGER *);
WINAPI(DWORD) WaitForSingleObject(HANDLE, DWORD);
WINAPI(int) CloseHandle(HANDLE);
WINAPI(DWORD) GetCurrentThreadId(void);
WINAPI(DWORD) GetActiveProcessorCount(unsigned short);
WINAPI(void) AcquireSRWLockExclusive(PSRWLOCK);
WINAPI(void) ReleaseSRWLockExclusive(PSRWLOCK);
WINAPI(void) WakeConditionVariable(PCONDITION_VARIABLE);
WINAPI(void) WakeAllConditionVariable(PCONDITION_VARIABLE);
WINAPI(int) SleepConditionVariableSRW(PCONDITION_VARIABLE, PSRWLOCK, DWORD, DWORD);
typedef HANDLE FARPROC;
END
    sed '/winsock2/d' "$work/after.c" > "$work/msvc/after.c"
    cp "$work/before.c" "$work/msvc/before.c"
    for flags in "" -DPBW_NO_THREADS -DPBW_WIDE; do
        # shellcheck disable=SC2086
        check "MSVC, by clang $flags: C" $msvc -std=c11 $flags -Wall -Wextra -Werror -I"$work/msvc" -I. \
            -fsyntax-only "$work/whole.c"
        for file in whole msvc/before msvc/after; do
            # shellcheck disable=SC2086
            check "MSVC, by clang $flags: C++, $file" $msvc -std=c++14 $flags -Wall -Wextra -Werror -I"$work/msvc" -I. \
                -fsyntax-only -x c++ "$work/$file.c"
        done
    done
    # Companions whose threads share words, and count together.
    for header in cells tiles; do
        printf '#define PBW_%s_IMPLEMENTATION\n#include "pbw_%s.h"\n' \
            "$(echo $header | tr a-z A-Z)" $header > "$work/msvc/$header.c"
        # shellcheck disable=SC2086
        check "MSVC, by clang: pbw_$header.h" $msvc -std=c11 -O1 -Wall -Wextra -Werror -I"$work/msvc" -I. -Iexamples/lib \
            -S "$work/msvc/$header.c" -o "$work/msvc/$header.s"
    done
    check "MSVC, by clang: pbw_tiles.h counts by atomic operations" grep 'lock' "$work/msvc/tiles.s"
    if $other-gcc "$work/empty.c" -o "$work/empty" > /dev/null 2>&1; then
        printf 'int _fltused;\n' > "$work/msvc/float.c"
        # shellcheck disable=SC2086
        check "MSVC, by clang: an object file" $msvc -std=c11 -O1 -mstack-probe-size=1000000000 -I"$work/msvc" -I. \
            -c "$work/whole.c" -o "$work/msvc/whole.o"
        check "MSVC, by clang: a test links" $other-gcc -std=c99 -O1 -I. -Iexamples/lib tests/test_answer.c "$work/msvc/whole.o" \
            "$work/msvc/float.c" -o "$work/msvc/answer.exe"
        if command -v wine > /dev/null; then
            export WINEPREFIX="$(cd "$work" && pwd)/wine" WINEDEBUG=-all
            check "MSVC, by clang: the test passes" timeout 600 \
                wine "$work/msvc/answer.exe" --filter collinear --filter "threads: 2D uniform"
            wineserver -k -w
            rm -rf "$WINEPREFIX"
        fi
    fi
else
    skip "MSVC: no clang that knows it"
fi
if $CC -m32 "$work/empty.c" -o "$work/empty" > /dev/null 2>&1; then
    compiled="-DPBW__IMPLEMENTED $work/$(basename "${CC%% *}").o"
    check "-m32: x87 arithmetic is a compile error" refuses '-msse2 -mfpmath=sse' \
        $CC -m32 -mno-sse -std=c99 -I. -c "$work/alone.c" -o "$work/x87.o"
    # shellcheck disable=SC2086
    check "-m32: a test compiles" $CC -m32 -msse2 -mfpmath=sse -std=c99 -O1 -I. -Iexamples/lib $compiled \
        tests/test_answer.c -o "$work/answer32" -lpthread -lm
    check "-m32: the test passes" "$work/answer32" --count 1000
    # shellcheck disable=SC2086
    check "-m32: the quick start compiles" \
        $CC -m32 -msse2 -mfpmath=sse -O1 -I. $compiled "$work/quickstart.c" -o "$work/quick32" -lpthread
    check "-m32: the quick start prints the same" sh -c "$work/quick32 | cmp - $work/printed"
fi

finish
