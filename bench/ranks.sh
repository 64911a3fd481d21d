#!/bin/sh
# ranks.sh FOLDER [COUNT [SCRATCH [PART...]]]: with the programs in FOLDER (mpi, pbw, bench_ranks, bench_tiles):
#   ranks   2, 4, 8 and 16 ranks of one thread beside 2, 4, 8 and 16 threads, COUNT points (default 4,000,000) a rank;
#           and 16 cores as 2 x 8 and 4 x 4.  RANKS="8": that number alone
#   ten     8 ranks of 10,000,000 points: halo and memory
#   halo    64 ranks, the work of 8 of them, of which one has others on all sides
#   core    out of core, within LIMIT (default 24G), without links: 75 x COUNT points, or what the disk has room for
# PART: some of these, by default all.  SCRATCH: a folder for points and meshes, on a disk; POINTS: another for points;
# FILES: another for the scratch files of pbw tiles.
# MPIRUN: the launcher.
bin=$(cd "$1" && pwd) || exit 2
count=${2:-4000000} scratch=${3:-$bin/ranks}
shift $(($# < 3 ? $# : 3))
parts=${*:-ranks ten halo core} folder=${POINTS:-$scratch}
points=$folder/points.bin
mpirun=${MPIRUN:-mpirun --oversubscribe --bind-to none}
mkdir -p "$scratch" "$folder" || exit 2
OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_ALLOW_RUN_AS_ROOT OMPI_ALLOW_RUN_AS_ROOT_CONFIRM
[ "$(getconf _NPROCESSORS_ONLN)" -ge 16 ] && OMPI_MCA_mpi_yield_when_idle=0 && export OMPI_MCA_mpi_yield_when_idle

# The best of some lines by the sum of the seconds of all phases but reading; adds that sum.
best() {
    awk '/ ranks?, | threads?: / { line = $0; sub(/.*seconds: /, ""); sub(/read [0-9.]*,/, ""); gsub(/[a-z,]/, "")
                      sum = 0
                      for (i = 1; i <= NF; i++) sum += $i
                      if (found == "" || sum < least) { least = sum; found = line }
                      next }
         { print }
         END { if (found != "") printf "%s; sum %.2f\n", found, least }'
}
run_ranks() {   # run_ranks RANKS THREADS POINTS-FILE TIMES
    seq "$4" | while read -r _; do
        $mpirun -np "$1" "$bin/mpi" "$3" --threads "$2" 2>&1 < /dev/null
    done | best
}

core() {    # core POINTS: 24 bytes a point of input, 44 of scratch files, 146 of simplices and points
    each=146
    [ -z "$FILES" ] && each=$((each + 44))
    [ "$folder" = "$scratch" ] && each=$((each + 24))
    room=$(df -Pk "$scratch" | awk -v each=$each 'END { printf "%.0f", $4 * 1024 * 0.97 / each }')
    n=$1
    [ "$n" -gt "$room" ] && n=$room
    "$bin/bench_ranks" --write "$points" "$n" || exit 1
    start=$(date +%s)
    "$bin/pbw" tiles --memory-limit "${LIMIT:-24G}" --tiles 96 --no-links "$points" -o "$scratch/mesh.pbwt" \
        --scratch "${FILES:-$scratch/files}" > "$scratch/log" 2>&1 &
    while kill -0 $! 2> /dev/null; do
        sed -n 's/^VmHWM: */resident at most: /p' /proc/$!/status > "$scratch/now" 2> /dev/null
        [ -s "$scratch/now" ] && mv "$scratch/now" "$scratch/most"
        sleep 0.5
    done
    wait $!
    echo "status $?, $(($(date +%s) - start)) s"
    cat "$scratch/most"
    sed -n '1p; 2p; 50p' "$scratch/log"
    tail -n 3 "$scratch/log"
    ls -l "$scratch/mesh.pbwt"
}

for part in $parts; do
    echo "== $part"
    case $part in
    ranks)
        for n in ${RANKS:-2 4 8 16}; do
            "$bin/bench_ranks" --write "$points" $((count * n)) || exit 1
            for _ in 1 2 3; do           # of a process of its own each, as ranks are
                "$bin/bench_ranks" "$points" $n
            done | best
            run_ranks $n 1 "$points" 3
        done
        [ -n "$RANKS" ] || run_ranks 2 8 "$points" 2
        [ -n "$RANKS" ] || run_ranks 4 4 "$points" 2 ;;
    ten)
        "$bin/bench_ranks" --write "$points" $((count * 20)) || exit 1
        run_ranks 8 1 "$points" 1 ;;
    halo)
        "$bin/bench_tiles" 64 $((count * 5 / 2)) uniform 8 ;;
    core)
        core $((count * 75)) ;;
    *)
        echo "$part: no such part" >&2
        exit 2 ;;
    esac
done
rm -rf "$points" "$scratch/mesh.pbwt" "${FILES:-$scratch/files}" "$scratch/log" "$scratch/now" "$scratch/most"
