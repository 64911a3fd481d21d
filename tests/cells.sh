#!/bin/sh
# cells.sh FOLDER: builds and runs tests/oracle_voro.cpp in there, where voro++ is installed.
if ! printf '#include <voro++/voro++.hh>\n' | ${CXX:-c++} -E -x c++ - > "$1/voro.txt" 2>&1
then
    echo "skipped voro++: not installed"
    echo "0 passed, 0 failed, 1 skipped"
elif ${MAKE:-make} B="$1" "$1/oracle_voro" > "$1/voro.txt" 2>&1
then
    "$1/oracle_voro"
else
    cat "$1/voro.txt"
    exit 2
fi
