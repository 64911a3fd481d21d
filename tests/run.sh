#!/bin/sh
# run.sh LOG COMMAND...: runs a test program, keeps its output in LOG, shows the faults and the last line.
#     A program that has not ended after TEST_SECONDS (1800) is killed and failed: it hangs, on however busy a machine.
# run.sh --total LOG...: adds up the last lines; a log that ends with anything else was cut short, so it failed.
if [ "$1" = --total ]; then
    shift
    for log; do
        [ -f "$log" ] || { echo "$(basename "$log" .log): FAILED, did not get as far as running" | tee "$log"; }
    done
    awk 'function add() { if (last ~ /^[0-9]+ passed, [0-9]+ failed, [0-9]+ skipped$/) { split(last, n, " ")
             passed += n[1]; failed += n[3]; skipped += n[5] } else failed++ }
         FNR == 1 && NR > 1 { add() }
         { last = $0 }
         END { add(); printf "%d passed, %d failed, %d skipped\n", passed, failed, skipped; exit failed > 0 }' "$@"
    exit
fi
log=$1
shift
limit=
command -v timeout > /dev/null && limit="timeout --foreground -k 10 ${TEST_SECONDS:-1800}"
$limit "$@" > "$log" 2>&1
code=$?
[ "$code" = 124 ] && [ -n "$limit" ] && echo "killed: it ran for more than ${TEST_SECONDS:-1800} seconds" >> "$log"
last=$(tail -n 1 "$log")
case "$code $last" in
0*" passed, 0 failed, "*" skipped" | 1*" passed, "[1-9]*" failed, "*" skipped") ;;
*) last="exit status $code, and no count of failures to explain it"; echo "$last" >> "$log" ;;
esac
sed -e '/ passed, .* skipped$/d' -e '/^passed /d' -e "s|^|$(basename "$log" .log): |" "$log" | head -n 40
times > "$log.times"
cpu=$(tail -n 1 "$log.times" | tr 'ms' '  ' | awk '{ printf "%.0f", 60 * ($1 + $3) + $2 + $4 }')
rm -f "$log.times"
echo "$(basename "$log" .log): $last ($cpu s of processors)"
