# check.sh: what scripts of tests share, by `. tests/check.sh` once $work, a folder for their files, is named.
passed=0 failed=0 skipped=0
rm -rf "$work" && mkdir -p "$work" || exit 2

check() {   # check NAME COMMAND...
    name=$1
    shift
    [ -z "$VERBOSE" ] || times > "$work/began"
    if "$@" > "$work/out" 2>&1; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED $name"
        tail -n 8 "$work/out" | sed 's/^/    /'
    fi
    [ -z "$VERBOSE" ] || { times > "$work/ended"; took "$name"; }
}
took() {    # took NAME: the processors' seconds of a check, with VERBOSE
    cat "$work/began" "$work/ended" | tr 'ms' '  ' | awk -v name="$1" '{ t += (NR > 2 ? 1 : -1) * (60 * ($1 + $3) + $2 + $4) }
        END { printf "%s: %.2f s of processors\n", name, t }'
}
says() {    # says STATUS TEXT ARGUMENT...: the exit status of $pbw, and a line of its output, in the file said, with the text
    status=$1 text=$2
    shift 2
    "$pbw" "$@" < /dev/null > said 2>&1
    code=$?
    cat said
    [ $code = "$status" ] && grep -qF -- "$text" said
}
has() { command -v "$1" > /dev/null; }                  # has PROGRAM
in_full() { [ -n "$QUICK" ] || check "$@"; }            # what `make test` leaves to `make test-all`
skip() { skipped=$((skipped + 1)); echo "skipped $1"; }
finish() {  # the last line and the exit status that tests/run.sh expects
    echo "$passed passed, $failed failed, $skipped skipped"
    [ "$failed" = 0 ]
    exit
}
