#!/bin/sh
# wraps.sh PROGRAM [MODEL...]: runs PROGRAM, made of bench/wraps.c, on the models, without any on CGAL's demo data.
program=$(realpath "$1")
shift || exit 2
. bench/common.sh
list_models "$@"
tr '\n' '\0' < "$work/list" | xargs -0 "$program"
