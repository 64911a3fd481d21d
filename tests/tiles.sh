#!/bin/sh
# tiles.sh FOLDER: pbw tiles, hash, check and convert of FOLDER/pbw: the same triangulation as at once, for many kinds
# of points; files that are damaged, disks that are full, runs that are killed; and examples/mpi.c over MPI, with QUICK
# a few runs of each kind.
bin=$(cd "$1" && pwd)
root=$(pwd)
pbw=$bin/pbw work=$bin/tiles
. tests/check.sh
cd "$work" || exit 2

cat > points.c << 'END'
/* points KIND DIM COUNT WEIGHTS: doubles of that kind of points, a tenth of them twice; WEIGHTS 0: none. */
#include "inputs.h"
#include <stdio.h>
#include <stdlib.h>
int main(int argc, char **argv)
{
    const int dim = atoi(argv[2]), weights = atoi(argv[4]);
    const size_t n = (size_t)atol(argv[3]) + (size_t)(argc > 5), d = (size_t)dim;
    double *x = (double *)malloc(n * d * sizeof *x), *w = (double *)malloc(n * sizeof *w);
    size_t i;
    input_fill(atoi(argv[1]), dim, n, 1, x);
    input_fill_weights(weights, dim, n, 1, x, w);
    for (i = 0; i < n / 10 * d; i++) {
        x[n * d - 1 - i] = x[n / 2 * d - 1 - i];
    }
    for (i = 0; i < n; i++) {
        fwrite(x + i * d, sizeof *x, d, stdout);
        if (weights != 0) {
            fwrite(w + i, sizeof *w, 1, stdout);
        }
    }
    return 0;
}
END
# shellcheck disable=SC2086
${CC:-cc} -std=c99 $CFLAGS -I"$root/tests" points.c -o points -lm || exit 2
for kind in 0 4 5 3; do
    for dim in 2 3; do
        ./points $kind $dim $([ $kind = 3 ] && echo 1500 || echo 3000) 0 > k$kind.$dim.bin
    done
done
./points 0 3 3000 4 > weighted.bin
./points 0 3 100000 0 > long.bin

hash_of() { "$pbw" hash --quiet "$@"; }
# The hash by pbw hash of a .bin file in one tile, which is one triangulation; and in some tiles.
equal() {   # equal TILES INPUT [OPTION...]
    tiles=$1 input=$2
    shift 2
    "$pbw" tiles "$input" "$@" --tiles 1 -o one.pbwt > said 2>&1 || { cat said; return 1; }
    "$pbw" tiles "$input" "$@" --tiles "$tiles" -o some.pbwt > said 2>&1 || { cat said; return 1; }
    hash_of one.pbwt > one && hash_of some.pbwt > some && cmp one some && ! [ -e some.pbwt.scratch ]
}

for kind in 0 4 5 3; do
    for dim in 2 3; do
        check "kind $kind in ${dim}D in tiles" equal 5 k$kind.$dim.bin --dim $dim
        check "kind $kind in ${dim}D is proved" says 0 "valid" check some.pbwt
        check "kind $kind in ${dim}D without links" equal 3 k$kind.$dim.bin --dim $dim --no-links
    done
done
check "weighted points in tiles" equal 6 weighted.bin --weights w
check "weighted points are proved" says 0 "valid" check some.pbwt
"$pbw" mesh --generate clusters 4000 --quiet -o clusters.csv
same_as_mesh() {
    "$pbw" tiles clusters.csv --tiles 4 -o c.pbwt > said 2>&1 && hash_of c.pbwt > one && hash_of clusters.csv > two &&
        cmp one two
}
check "the same as at once" same_as_mesh
without_mesh() {
    "$pbw" tiles clusters.csv --tiles 4 --no-mesh > said 2>&1 && grep "hash $(cat one)" said &&
        ! ls -d clusters.csv.*
}
check "counts and the hash without a file" without_mesh
check "no file, without links" says 2 "--no-links and --no-mesh exclude each other" \
    tiles clusters.csv --no-mesh --no-links
check "no file, and one" says 2 "with --no-mesh none" tiles clusters.csv --no-mesh -o c2.pbwt
as_bin() {      # as_bin OPTION...: points of a text as .bin are the same to pbw tiles
    "$pbw" convert weighted.csv "$@" -o weighted2.bin > said && cmp weighted2.bin "$bin_of" &&
        "$pbw" tiles weighted2.bin "$@" --tiles 2 -o w.pbwt > said && hash_of w.pbwt > one &&
        hash_of weighted.csv "$@" > two && cmp one two
}
python3 -c 'import struct
row = list(struct.iter_unpack("4d", open("weighted.bin", "rb").read()))
open("weighted.csv", "w").write("x,y,z,w\n" + "".join("%r,%r,%r,%r\n" % r for r in row))
open("places.bin", "wb").write(b"".join(struct.pack("3d", *r[:3]) for r in row))' || touch weighted.csv
if [ -s weighted.csv ]; then
    bin_of=weighted.bin
    check "convert writes .bin with weights" as_bin --weights w
    bin_of=places.bin
    check "convert writes .bin" as_bin
    check "weights need a .bin" says 2 "--weights" convert weighted.csv --weights w -o w.xyz
fi
nothing_left() {     # nothing_left NAME SAYS-ARGUMENT...: no scratch files and no part of an output
    beside=$1
    shift
    says "$@" && ! ls -d "$beside".*
}
check "no file, and leftovers" nothing_left k3.3.bin 1 "--no-mesh does not do them" tiles k3.3.bin --tiles 3 --no-mesh

# On a terminal: after an interruption nothing is drawn behind the words that tell it.
cat > interrupt.py << 'END'
import os, pty, signal, subprocess, sys
outer, inner = pty.openpty()
run = subprocess.Popen(sys.argv[1:], stdin=inner, stdout=inner, stderr=inner)
os.close(inner)
said = b""
try:
    while True:
        more = os.read(outer, 4096)
        if not more:
            break
        if b" 1 of 24: " in said + more and b" 1 of 24: " not in said:
            run.send_signal(signal.SIGINT)
        said += more
except OSError:                                      # the end on Linux
    pass
run.wait()
told = said.find(b"interrupted; ")
sys.exit(told < 0 or b"several" in said[told:])
END
if command -v python3 > /dev/null; then
    check "nothing is drawn behind an interruption" timeout 600 python3 interrupt.py "$pbw" tiles long.bin --tiles 24 \
        --threads 4 --work 4 -o i.pbwt
else
    skip "no python3 for a terminal"
fi

# Files that are damaged: every tenth of the file, one byte changed.
size=$(wc -c < c.pbwt)
damaged() {
    cp c.pbwt bad.pbwt
    printf '\377\376\375\374\373\372\371\370' | dd of=bad.pbwt bs=1 seek="$1" conv=notrunc 2> /dev/null
    ! "$pbw" check bad.pbwt > said 2>&1 && [ $? -lt 2 ] && grep '^pbw: ' said
}
for tenth in 0 1 2 3 4 5 6 7 8 9; do
    check "damage at $tenth tenths" damaged $((tenth * size / 10 + 48))
done
# Files that are wrong, with checksums that are right.
cat > forge.c << 'END'
/* forge FILE HOW: changes a tile and its checksums. */
#include "pbw_tilefile.h"
#include <stdlib.h>
int main(int argc, char **argv)
{
    const int how = argc > 2 ? atoi(argv[2]) : 0;
    static char data[4000000];
    FILE *file = fopen(argv[1], "rb+");
    const size_t size = fread(data, 1, sizeof data, file), head = sizeof(pbwtf_chunk);
    pbwtf_header *header = (pbwtf_header *)(void *)data;
    pbwtf_entry *entry = (pbwtf_entry *)(void *)(data + header->table);
    pbwtf_chunk *chunk = (pbwtf_chunk *)(void *)(data + entry->offset);
    char *at = (char *)chunk;
    double *own = (double *)(void *)(at + head);
    uint32_t *simplex = (uint32_t *)(void *)(at + head + chunk->own * 32), other = simplex[0];
    uint64_t *across = (uint64_t *)(void *)(at + pbwtf_across_offset(chunk));
    size_t i;
    if (how == 0) {                                  /* turned */
        simplex[0] = simplex[1];
        simplex[1] = other;
    } else if (how == 1) {                           /* a link that does not lead back */
        for (i = 0; simplex[i % 8 + i / 8 * 8] >= 0x80000000u || i % 8 < 4; i++) {
        }
        simplex[i]++;
    } else if (how == 2) {                           /* a facet between tiles that pretends to be of the hull */
        for (i = 0; across[i] == PBWT_NOTHING; i++) {
        }
        across[i] = PBWT_NOTHING;
    } else if (how == 3) {                           /* a point moved */
        own[0] += 1e-3;
    } else {                                         /* a simplex missing at the end */
        chunk->simplices--;
    }
    chunk->checksum = pbwtf_checksum(0, at + head, pbwtf_across_offset(chunk) - head);
    entry->across_checksum = pbwtf_checksum(0, across, chunk->across * 8);
    rewind(file);
    return fwrite(data, 1, size, file) != size || fclose(file) != 0;
}
END
# shellcheck disable=SC2086
${CC:-cc} -std=c99 $CFLAGS -I"$root" -I"$root/examples/lib" forge.c -o forge "$bin/companions.a" "$bin/libpbw.a" \
    -lpthread -lm || exit 2
forged() {
    cp c.pbwt bad.pbwt && ./forge bad.pbwt "$1" && ! "$pbw" check bad.pbwt > said 2>&1 && cat said &&
        ! grep checksum said && grep '^pbw: ' said
}
for how in 0 1 2 3 4; do
    check "forgery $how" forged $how
done
truncated() { head -c $((size - $1)) c.pbwt > bad.pbwt && says 1 truncated check bad.pbwt; }
check "a truncated file" truncated 8
head -c 71993 k0.3.bin > short.bin
check "a truncated input" says 1 "truncated: its size, 71993, is no multiple of 24" tiles short.bin -o no.pbwt
check "no such input" says 1 "No such file" tiles none.bin -o no.pbwt
(cat k0.3.bin; printf '\0\0\0\0\0\0\370\177\0\0\0\0\0\0\370\177\0\0\0\0\0\0\370\177') > nan.bin
check "a point that is not finite" nothing_left no.pbwt 1 "point 3000: a number is not finite" \
    tiles nan.bin -o no.pbwt
head -c 7200 /dev/zero > zero.bin
check "points that span nothing" nothing_left no.pbwt 1 "do not span the space" tiles zero.bin --tiles 3 -o no.pbwt
check "links are needed for a proof" sh -c "'$pbw' tiles k0.3.bin --no-links -o n.pbwt && ! '$pbw' check n.pbwt"
check "too little memory" says 1 "more --tiles need less" tiles long.bin --tiles 2 --memory-limit 3M -o m.pbwt
check "and scratch files stay for more of it" [ -e m.pbwt.scratch/state ]
rm -rf m.pbwt*
"$pbw" mesh --generate sphere 20000 --quiet -o sphere.csv
awk -F, -v OFS=, 'NR > 1 { $2 *= 0.7; $3 *= 0.4 } { print }' sphere.csv > ellipsoid.csv
check "a surface that memory does not hold at once" says 1 "points, as on surfaces, which must be" \
    tiles ellipsoid.csv --tiles 8 --threads 1 --memory-limit 7M -o m.pbwt
with_more() { says 0 "8 of 8 tiles are finished" tiles ellipsoid.csv --tiles 8 --threads 1 -o m.pbwt; }
check "more memory goes on from there" with_more
check "too little memory for tiles of its choice" nothing_left n.pbwt 1 "out of memory within --memory-limit 4M" \
    tiles ellipsoid.csv --threads 1 --memory-limit 4M -o n.pbwt
halo() {    # halo HALO: points of the first halos, by the report
    "$pbw" tiles few.bin --tiles 4 --halo "$1" -o halo.pbwt > said && hash_of halo.pbwt > "halo.$1" &&
        awk '/^tile/ { for (i = 1; i < NF; i++) if ($i == "halo") sum += $(i + 1) } END { print sum + 0 }' said
}
wider() { few=$(halo 0.5) && many=$(halo 3) && [ "$many" -gt "$((2 * few))" ] && cmp halo.0.5 halo.3; }
./points 0 3 5000 0 > few.bin
check "--halo: more points of others, the same triangulation" wider
elsewhere() {    # scratch files stay as memory is too small, in that folder
    says 1 "more --tiles need less" tiles long.bin --tiles 2 --memory-limit 3M --scratch else -o m.pbwt &&
        [ -e else/state ] && ! [ -e m.pbwt.scratch ] && says 0 "all " tiles long.bin --tiles 2 \
        --scratch else -o m.pbwt && ! [ -e else ]
}
check "--scratch" elsewhere
check "a folder for scratch files that cannot be" says 1 "none/else: No such file" \
    tiles long.bin --scratch none/else -o m.pbwt
peak() {    # peak KB ARGUMENT...: the memory of a run is at most that
    most=$1
    shift
    command -v python3 > /dev/null || { "$pbw" "$@" > said; return; }
    python3 -c 'import resource, subprocess, sys
code = subprocess.call(sys.argv[2:])
most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(most, "KB")
sys.exit(code or most > int(sys.argv[1]))' "$most" "$pbw" "$@"
}
check "memory of a run: the limit and a tenth" peak 21484 tiles long.bin --memory-limit 20M --threads 1 -o peak.pbwt
# A proof holds a tile and at most 24 MiB of the file, which has 65 MB here.
if [ -z "$QUICK" ]; then
    ./points 0 3 250000 0 > large.bin
    "$pbw" tiles large.bin --tiles 12 -o large.pbwt > said
fi
in_full "memory of a proof: not that of the file" peak 48000 check large.pbwt
rm -f large.bin large.pbwt
check "enough memory" says 0 "all " tiles long.bin --memory-limit 12M -o m.pbwt

# Several at a time: the same bytes for any number of threads; fewer if memory is too small for that.
at_a_time() {   # at_a_time INPUT ARGUMENT...
    input=$1
    shift
    for threads in 1 2 5; do
        "$pbw" tiles "$input" "$@" --threads $threads -o $threads.pbwt > said 2>&1 || { cat said; return 1; }
    done
    cmp 1.pbwt 2.pbwt && cmp 1.pbwt 5.pbwt
}
check "the same bytes for any number of threads" at_a_time long.bin --tiles 7
check "the same bytes for any number of threads, leftovers" at_a_time k3.3.bin --tiles 7 --work 1
in_full "the same bytes for any number of threads, limit" at_a_time long.bin --memory-limit 20M
fewer() {
    says 0 "little memory: on with 1 at a time" tiles k0.3.bin --tiles 5 --threads 2 --memory-limit 600K -o 5.pbwt &&
        "$pbw" tiles k0.3.bin --tiles 5 -o 1.pbwt > said && cmp 1.pbwt 5.pbwt
}
check "little memory, so fewer at a time" fewer

# Standard streams that are closed: the report goes nowhere, not into the output that gets its number.
closed() {
    "$pbw" tiles few.bin --tiles 2 -o open.pbwt > said && "$pbw" tiles few.bin --tiles 2 -o closed.pbwt <&- >&- 2>&-
    cmp open.pbwt closed.pbwt
}
check "standard streams that are closed" closed

# Two runs at once: of one output one is told who works there, and the other is whole; of two folders both are.
at_once() {
    for try in 1 2; do
        "$pbw" tiles long.bin --tiles 8 -o pair.pbwt > first 2>&1 & one=$!
        "$pbw" tiles long.bin --tiles 8 -o pair.pbwt > second 2>&1
        two=$?
        wait $one
        one=$?
        cat first second
        [ $((one + two)) = 0 ] || { [ $((one + two)) = 1 ] && cat first second | grep 'is in use: process [0-9]* works'; } ||
            return 1
        cmp m8.pbwt pair.pbwt && ! ls -d pair.pbwt.* || return 1
    done
}
two_folders() {
    "$pbw" tiles long.bin --tiles 8 --scratch one.scratch -o pair.pbwt > first 2>&1 & one=$!
    "$pbw" tiles long.bin --tiles 8 --scratch two.scratch -o pair.pbwt > second 2>&1 && wait $one &&
        cmp m8.pbwt pair.pbwt && ! ls -d pair.pbwt.* one.scratch two.scratch
}
"$pbw" tiles long.bin --tiles 8 -o m8.pbwt > said
check "two runs on one output" at_once
in_full "two runs on one output in two folders" two_folders
kept_part() {   # a user's file, or link, of a name that runs once used
    echo mine > kept.pbwt.part && ln -s kept.pbwt.part kept2.pbwt.part && "$pbw" tiles few.bin -o kept.pbwt > said &&
        "$pbw" tiles few.bin -o kept2.pbwt > said && grep mine kept.pbwt.part && [ -h kept2.pbwt.part ]
}
check "files named .part are kept" kept_part

# A tile as a mesh.
part() { "$pbw" convert c.pbwt --tile 2 -o part.vtu > said && grep -q '</VTKFile>' part.vtu; }
check "a tile as .vtu" part
check "no such tile" says 1 "--tile 9: there are" convert c.pbwt --tile 9 -o part.vtu
check "which tile" says 2 "--tile is needed" convert c.pbwt -o part.vtu
check "points have no simplices" says 1 "pbw mesh makes them of its points" convert clusters.csv -o part.vtu

# A disk that is full, by a limit of the size of files, then more room; a run that is killed.
full() {
    (ulimit -f 2000; trap '' XFSZ; "$pbw" tiles long.bin --tiles 8 -o f.pbwt > said 2>&1) && return 1
    cat said
    grep -q 'what is finished stays' said && ! [ -e f.pbwt ] &&
        "$pbw" tiles long.bin --tiles 8 -o f.pbwt > said 2>&1 && cat said && hash_of f.pbwt > one &&
        hash_of m.pbwt > two && cmp one two
}
check "a full disk" full
killed() {
    "$pbw" tiles long.bin --tiles 8 -o g.pbwt > going 2>&1 &
    number=$!
    while ! grep -q ' 2 of 8' going && kill -0 $number 2> /dev/null; do sleep 0.05; done
    kill -9 $number 2> /dev/null
    wait $number
    "$pbw" tiles long.bin --tiles 8 -o g.pbwt > said 2>&1 && cat said && cmp f.pbwt g.pbwt && ! [ -e g.pbwt.scratch ]
}
check "a killed run goes on" killed
stopped() {    # by Ctrl-C, which shells turn off for what runs behind; once more if it came too late
    for try in 1 2 3 4 5 6 7 8 9; do
        env --default-signal=INT "$pbw" tiles long.bin --tiles 8 -o i.pbwt > going 2>&1 &
        number=$!
        while ! grep -q ' 2 of 8' going && kill -0 $number 2> /dev/null; do sleep 0.05; done
        kill -INT $number 2> /dev/null
        wait $number || break
        rm i.pbwt
    done
    cat going
    grep -q 'interrupted; [2-7] of 8 tiles are finished and kept in i.pbwt.scratch: the same command goes on' going &&
        ! [ -e i.pbwt ] && kept=$(sed -n 's/.*interrupted; \([2-7]\) of.*/\1/p' going) &&
        "$pbw" tiles long.bin --tiles 8 -o i.pbwt > said 2>&1 && cat said && cmp f.pbwt i.pbwt &&
        grep -q "going on: $kept of 8 tiles are finished" said && [ "$(grep -c "^tile " said)" = $((8 - kept)) ] &&
        ! [ -e i.pbwt.scratch ]
}
if env --default-signal=INT true 2> /dev/null; then
    check "Ctrl-C keeps what is finished, and says so" stopped
else
    skip "Ctrl-C: env cannot turn it on"
fi
half() {    # leaves some of 8 tiles finished
    ! (ulimit -f 20000; trap '' XFSZ; "$pbw" tiles long.bin --tiles 8 -o h.pbwt > said 2>&1) &&
        grep -q ' 1 of 8' said && [ -e h.pbwt.scratch/state ]
}
another() { # scratch files are not used for other points, whatever their number
    for other in $([ -n "$QUICK" ] || echo few.bin) moved.bin; do
        half && "$pbw" tiles $other --tiles 8 -o h.pbwt > said 2>&1 && cat said && hash_of h.pbwt > one &&
            "$pbw" tiles $other --tiles 1 -o one.pbwt > said 2>&1 && hash_of one.pbwt > two && cmp one two &&
            ! [ -e h.pbwt.scratch ] || return 1
    done
}
./points 2 3 100000 0 > moved.bin
check "scratch of another input" another
missing() { # nor where the output that grew is gone
    half && rm h.pbwt.part.* && "$pbw" tiles long.bin --tiles 8 -o h.pbwt > said 2>&1 && cat said && cmp f.pbwt h.pbwt
}
check "scratch without its output" missing
check "no hull is counted without links" says 0 "simplices, 500 duplicates" tiles few.bin --no-mesh

# Over MPI.
if command -v mpirun > /dev/null && [ -x "$bin/mpi" ]; then
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
    OMPI_MCA_mpi_yield_when_idle=1
    export OMPI_ALLOW_RUN_AS_ROOT OMPI_ALLOW_RUN_AS_ROOT_CONFIRM OMPI_MCA_rmaps_base_oversubscribe
    export OMPI_MCA_mpi_yield_when_idle
    ranks() {   # ranks COUNT INPUT [OPTION...]: the hash of one tile, and a valid file
        count=$1 input=$2
        shift 2
        mpirun -np "$count" "$bin/mpi" "$input" "$@" -o r.pbwt > said 2>&1 || { cat said; return 1; }
        cat said
        "$pbw" tiles "$input" "$@" --tiles 1 -o one.pbwt > /dev/null 2>&1 && hash_of one.pbwt > one &&
            hash_of r.pbwt > two && cmp one two && "$pbw" check r.pbwt
    }
    check "MPI: 4 ranks" ranks 4 k4.3.bin
    check "MPI: 3 ranks in 2D, leftovers" ranks 3 k3.2.bin --dim 2
    check "MPI: 2 ranks, weighted" ranks 2 weighted.bin --weights w
    in_full "MPI: 16 ranks" ranks 16 k0.3.bin
    in_full "MPI: 1 rank" ranks 1 few.bin
    in_full "MPI: 5 ranks" ranks 5 long.bin
    [ -n "$QUICK" ] || ./points 0 3 300000 0 > many.bin      # of which 75,000 travel each way, in three bundles
    in_full "MPI: 2 ranks of many points" ranks 2 many.bin
    mpi_fails() {   # mpi_fails TEXT ARGUMENT...
        text=$1
        shift
        ! mpirun -np 3 "$bin/mpi" "$@" > said 2>&1 && cat said && grep -qF -- "$text" said
    }
    check "MPI: a truncated file" mpi_fails "truncated" short.bin -o no.pbwt
    in_full "MPI: a point that is not finite" mpi_fails "not finite" nan.bin -o no.pbwt
    in_full "MPI: too little memory" mpi_fails "memory" long.bin --memory-limit 3000000 -o no.pbwt
    in_full "MPI: no folder" mpi_fails "none/no.pbwt" k0.3.bin -o none/no.pbwt
    mpi_killed() {
        timeout 600 mpirun -np 3 "$bin/mpi" k0.3.bin --die 1 -o no.pbwt > said 2>&1
        code=$?
        cat said
        [ $code != 0 ] && [ $code != 124 ]
    }
    check "MPI: a rank that dies ends all" mpi_killed
    as_any() {      # a killed run of more ranks leaves a folder
        mkdir r.pbwt.scratch && touch r.pbwt.scratch/lock r.pbwt.scratch/0.chunk r.pbwt.scratch/4.chunk &&
            ranks 3 k0.3.bin --threads 2 && [ "$(echo r.pbwt*)" = r.pbwt ]
    }
    in_full "MPI: and the next run is as any" as_any
    # A run that fails when tiles are finished, as a folder has the name of the output, leaves them.
    late() {     # late INPUT
        rm -rf r.pbwt* && mkdir r.pbwt && mpi_fails "r.pbwt: " "$1" -o r.pbwt && rmdir r.pbwt &&
            [ "$(echo r.pbwt*)" = r.pbwt.scratch ] && [ -e r.pbwt.scratch/0.state ] &&
            [ -e r.pbwt.scratch/1.state ] && [ -e r.pbwt.scratch/2.state ]
    }
    goes_on() {  # goes_on RESUMED INPUT
        ranks 3 "$2" > log 2>&1 && cat log && grep -q "3 ranks, $1 resumed" log && [ "$(echo r.pbwt*)" = r.pbwt ]
    }
    flip() {     # flip FILE PLACE
        printf '\376' | dd of="r.pbwt.scratch/$1" bs=1 seek="$2" conv=notrunc 2> said
    }
    all_finished() { late k0.3.bin && goes_on 3 k0.3.bin; }
    one_killed() {  # before its tile was finished; and the chunk of another, or the state, is damaged
        late k0.3.bin && rm r.pbwt.scratch/1.state && goes_on 2 k0.3.bin && late k0.3.bin &&
            flip 2.chunk 3000 && flip 0.state 3000 && goes_on 1 k0.3.bin
    }
    flipped_head() {     # what the state says of its tile: the points, and numbers
        late k0.3.bin && flip 0.state 25 && flip 1.state 70 && goes_on 1 k0.3.bin
    }
    mpi_at_once() {      # two runs on one output, which goes nowhere but there
        echo mine > twice.pbwt.part && ln -s twice.pbwt.part twice.pbwt.0
        mpirun -np 2 "$bin/mpi" long.bin -o twice.pbwt > first 2>&1 & one=$!
        mpirun -np 2 "$bin/mpi" long.bin -o twice.pbwt > second 2>&1
        two=$?
        wait $one
        one=$?
        cat first second
        [ $((one + two)) = 0 ] || { [ $((one + two)) = 1 ] &&
            cat first second | grep 'is in use: process [0-9]* works'; } || return 1
        "$pbw" check twice.pbwt && hash_of twice.pbwt > one && hash_of f.pbwt > two && cmp one two &&
            grep mine twice.pbwt.0 && [ "$(echo twice.pbwt*)" = "twice.pbwt twice.pbwt.0 twice.pbwt.part" ]
    }
    in_full "MPI: two runs on one output" mpi_at_once
    of_others() {        # files with names of scratch files in a folder without a lock
        mkdir twice.pbwt.scratch && echo mine > twice.pbwt.scratch/1.chunk &&
            mpi_fails "files of other programs" k0.3.bin -o twice.pbwt && grep mine twice.pbwt.scratch/1.chunk &&
            ! [ -e twice.pbwt.scratch/lock ] && rm -r twice.pbwt.scratch
    }
    check "MPI: a folder of others" of_others
    check "MPI: finished tiles are taken up" all_finished
    in_full "MPI: those that are whole, if not all are" one_killed
    in_full "MPI: a state that is damaged" flipped_head
    with_leftovers() { late k3.3.bin && goes_on 3 k3.3.bin && ! grep -q ' 0 given up' log; }
    in_full "MPI: and leftovers made of them" with_leftovers
    other_points() { late k0.3.bin && goes_on 0 k4.3.bin; }
    in_full "MPI: not those of other points" other_points
    mpi_short() {   # a limit of rank 1's address space: its own allocations fail, outside of its tile
        for limit in 280000 320000 360000; do
            mpirun -np 3 sh -c "[ \$OMPI_COMM_WORLD_RANK != 1 ] || ulimit -v $limit
                exec '$bin/mpi' --generate 1000000" > said 2>&1 && return 1
            grep '^mpi: rank 1: .*memory' said && return 0
        done
        cat said
        return 1
    }
    in_full "MPI: a rank without memory ends all, and says so" mpi_short
else
    skip "MPI: no mpirun, or no mpicc"
fi
finish
