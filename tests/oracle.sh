#!/bin/sh
# oracle.sh FOLDER: builds and runs tests/oracle_cgal.cpp in there, where CGAL is installed.
headers='#include <CGAL/version.h>\n#include <gmp.h>\n#include <mpfr.h>\n'
if ! printf "$headers" | ${CXX:-c++} -E -x c++ - > "$1/cgal.txt" 2>&1
then
    echo "skipped CGAL: its headers, or those of GMP or MPFR, are not installed"
    echo "0 passed, 0 failed, 1 skipped"
elif ${MAKE:-make} B="$1" "$1/oracle_cgal" > "$1/cgal.txt" 2>&1
then
    "$1/oracle_cgal"
else
    cat "$1/cgal.txt"
    exit 2
fi
