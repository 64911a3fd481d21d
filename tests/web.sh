#!/bin/sh
# web.sh FOLDER: examples/web, built by emscripten: in Node.js, compared with delaunator where npm can install it; its
# page in a headless Chromium; the arrays byte for byte as a native program makes them.  Run from the root.
bin=$1 work=$1/web-test
. tests/check.sh
if ! command -v "${EMCC:-emcc}" > /dev/null || ! command -v node > /dev/null; then
    skip "WebAssembly: no emscripten, or no Node.js"
    finish
fi
for browser in "${CHROMIUM:-chromium}" chromium-browser google-chrome ''; do
    [ -n "$browser" ] && "$browser" --version > /dev/null 2>&1 && break
done

make_web() { ${MAKE:-make} --no-print-directory B="$1" EMCC="${EMCC:-emcc}" WEB_MEMORY="$2" web; }
make_homeless() { (unset EM_CACHE; HOME=/nonexistent make_web "$@"); }
check "make web" make_web "$bin" 4GB
check "make web, with little memory and without a home" make_homeless "$work/little" 32MB
mkdir "$work/project" && cp tests/web_use.mjs "$work/project" && echo '{}' > "$work/project/package.json"
if command -v npm > /dev/null; then
    check "a project can install it" npm install --prefix "$work/project" --offline --no-audit --no-fund \
        "$(cd "$bin/web" && pwd)"
    check "a project can use it" node "$work/project/web_use.mjs"
else
    skip "a project that installs it: no npm"
fi

# Types: what the README shows, as an ES module and as CommonJS; a wrong use is found.
npm install --prefix "$work/project" --no-audit --no-fund --fetch-retries=0 typescript > "$work/tsc.txt" 2>&1
tsc=node_modules/.bin/tsc
if [ -x "$work/project/$tsc" ]; then
    cat > "$work/project/use.mts" << 'END'
import Delaunay, { Delaunay3, type Polygon } from 'pbw';
const d = Delaunay.from([{ x: 1, y: 2 }], p => p.x, p => p.y, () => 3), v = d.voronoi([0, 0, 1, 1]);
const drawn: string | null = v.render(), cell: Polygon | null = v.cellPolygon(0);
for (const polygon of v.cellPolygons()) polygon.index.toFixed();
d.renderPoints(3)?.length;
export default [drawn, cell, d.inedges, new Delaunay3([0, 0, 0]).tetrahedra];
END
    sed 's/^import .*/import pbw = require("pbw"); import Delaunay = pbw.Delaunay; import Polygon = pbw.Polygon;/
        s/^export default/export =/; s/new Delaunay3/new pbw.Delaunay3/' \
        "$work/project/use.mts" > "$work/project/use.cts"
    echo 'import { Delaunay } from "pbw"; new Delaunay([]).voronoi([0, 1]).cells();' > "$work/project/wrong.mts"
    types() { (cd "$work/project" && "$tsc" --noEmit --strict --module node16 --target es2022 --lib es2022 "$@"); }
    wrong() { ! types wrong.mts > "$work/tsc.txt" && grep -q TS2339 "$work/tsc.txt"; }
    check "types of the ES module and of CommonJS" types use.mts use.cts
    check "types find a wrong use" wrong
else
    skip "types: npm could not install TypeScript"
fi

# Floating point of WebAssembly: all the inputs of hashes.c.
check "hashes.c compiles" "${CC:-cc}" -std=c99 -O2 -DPBW__IMPLEMENTED tests/hashes.c "$bin/libpbw.a" \
    -o "$work/hashes" -lpthread -lm
check "hashes.c compiles to WebAssembly" "${EMCC:-emcc}" -std=c99 -O1 -DPBW_NO_THREADS tests/hashes.c \
    -sALLOW_MEMORY_GROWTH -sWASM_ASYNC_COMPILATION=0 -o "$work/hashes.js"
check "native arrays" sh -c "$work/hashes > $work/native.txt && [ -s $work/native.txt ]"
check "arrays of WebAssembly, byte for byte" sh -c "node $work/hashes.js | diff $work/native.txt -"

npm install --prefix "$work" --no-audit --no-fund --fetch-retries=0 delaunator d3-delaunay > "$work/npm.txt" 2>&1
cat > "$work/rivals.mjs" << 'END'
export { default as Rival } from 'delaunator';
export { Delaunay as D3 } from 'd3-delaunay';
END
node tests/web.mjs "$bin/web" "$work" "$browser" > "$work/web.txt" 2>&1
sed '$d' "$work/web.txt"
counts=$(tail -n 1 "$work/web.txt")
case $counts in
[0-9]*" passed, "*" failed, "*" skipped")
    # shellcheck disable=SC2086
    set -- $counts
    passed=$((passed + $1)) failed=$((failed + $3)) skipped=$((skipped + $5)) ;;
*)  failed=$((failed + 1))
    echo "FAILED tests/web.mjs was cut short: $counts" ;;
esac
finish
