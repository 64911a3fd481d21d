#!/usr/bin/env python3
"""cuda_gate.py OLD NEW [ROW ...]: is the GPU as fast as with an older version?

OLD and NEW are two programs cuda_bench, which run in turn; the order within a round alternates.  For each row, from
and to memory of the device and of the host: the median of each side's medians, in milliseconds, their ratio, and the
ratio of the best times.  The last lines give the geometric means and the rows over the limit.  Exit status 1: a row
or a mean is over its limit, or a program failed.  Without a GPU: skipped.

    export CUDA_FLAGS="-O3 -arch=sm_90"
    git worktree add build/old cb6ae4d && make -C build/old build/cuda_bench && make build/cuda_bench
    python3 bench/cuda_gate.py build/old/build/cuda_bench build/cuda_bench
"""
import argparse
import math
import re
import statistics
import subprocess
import sys

from gate import LIMIT

# Those of cuda_bench that a GPU builds, without loops.
ROWS = ["uniform:3:1000000", "gauss:3:1000000", "ball:3:1000000", "clusters:3:1000000", "terrain:3:1000000",
        "lattice:3:1000000", "uniform:3:1000000:w", "uniform:2:1000000", "uniform:2:1000000:w", "lattice:2:1000000",
        "uniform:3:10000000", "uniform:2:10000000"]


def run(program, rows, runs):
    """Returns {(row, where): (best, median)}, empty without a GPU."""
    out = subprocess.run([program, "--cpu", "0", "--runs", str(runs), *rows], check=True, capture_output=True,
                         text=True).stdout
    times, row = {}, ""
    for line in out.splitlines():
        if re.match(r"\w.* [23]D \d+$", line):
            row = line
        found = re.match(r"  (device|host) +best ([\d.]+) median ([\d.]+) ms", line)
        if found:
            times[row, found[1]] = float(found[2]), float(found[3])
    return times


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("rows", nargs="*", default=ROWS)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--runs", type=int, default=7, help="builds of a row in a round")
    options = parser.parse_args()
    sides = {options.old: [], options.new: []}
    for turn in range(options.rounds):
        for program in list(sides)[::1 - turn % 2 * 2]:
            sides[program].append(run(program, options.rows, options.runs))
    old, new = sides[options.old], sides[options.new]
    if not new[0]:
        print("skipped: no CUDA device")
        return 0
    ratios, over = {"device": [], "host": []}, []
    print(f"{'row':28} {'where':6} {'old':>8} {'new':>8} {'ratio':>6} {'best':>6}")
    for row, where in dict.fromkeys(key for times in old + new for key in times):
        if not all((row, where) in times for times in old + new):
            over.append(f"{row}, {where}: not always built by the GPU")
            continue
        medians = [statistics.median(times[row, where][1] for times in side) for side in (old, new)]
        best = [min(times[row, where][0] for times in side) for side in (old, new)]
        ratio = medians[1] / medians[0]
        ratios[where].append(ratio)
        if ratio > LIMIT:
            over.append(f"{row}, {where}: {ratio:.3f}")
        print(f"{row:28} {where:6} {medians[0]:8.2f} {medians[1]:8.2f} {ratio:6.3f} {best[1] / best[0]:6.3f}")
    means = {where: math.exp(statistics.fmean(map(math.log, some))) for where, some in ratios.items() if some}
    print("geometric means: " + ", ".join(f"{where} {mean:.3f}" for where, mean in means.items()))
    print("over the limit: " + ("; ".join(over) or "none"))
    return 1 if over or any(mean > 1 for mean in means.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
