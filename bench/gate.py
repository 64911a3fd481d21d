#!/usr/bin/env python3
"""gate.py OLD.h NEW.h: is the new header as fast as the old one, with the same bytes?

Builds bench/gate_side.c with each header and runs the two in turn, each sample in a process of its own, old and new
next to each other; the order within a pair alternates.  A row is one kind of points, size and number of threads:
the medians of old and new, the median of the ratios new / old over the pairs, the ratio of the best times, the peak of
memory in bytes a point, and whether all bytes of the results agree.  The last lines give the geometric mean of the ratios and the rows over
the limits.  Exit status 1: bytes differ, memory grew, or a row or the mean is over its limit.

    git show cb6ae4d:pbw.h > build/old.h && python3 bench/gate.py build/old.h pbw.h
"""
import argparse
import concurrent.futures
import math
import os
import statistics
import subprocess
import sys
import time

KINDS = ["uniform", "gauss", "ball", "sphere", "clusters", "lattice", "lines", "spiral", "plane", "anisotropic",
         "terrain", "weighted"]
LOOSE = {"lines": 1.10, "sphere2": 1.10}              # in the plane a sphere is a circle
LIMIT = 1.03


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--dims", default="3,2")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--sizes", default="1e4,1e5,1e6")
    parser.add_argument("--threads", default="1,0", help="0: all")
    parser.add_argument("--pairs", type=int, default=9)
    parser.add_argument("--seconds", type=float, default=0, help="stop taking pairs of a row after so long; 0: never")
    parser.add_argument("--jobs", type=int, default=1, help="rows of one thread at a time")
    parser.add_argument("--flags", default="", help="options.flags of the new side only")
    parser.add_argument("--compiler", default=os.environ.get("CC", "cc"))
    parser.add_argument("--build", default="build")
    return parser.parse_args()


def build(options, header, name):
    program = os.path.join(options.build, name)
    subprocess.run([options.compiler, "-std=c99", "-O3", f'-DPBW_HEADER="{os.path.abspath(header)}"',
                    "bench/gate_side.c", "-o", program, "-lpthread", "-lm"], check=True)
    return program


def sample(program, row, flags=""):
    dim, kind, size, threads = row
    out = subprocess.run([program, str(dim), kind, str(size), str(threads)] + ([flags] if flags else []),
                         check=True, capture_output=True, text=True).stdout.split()
    return float(out[0]), float(out[1]), out[2]


def measure(options, old, new, row):
    pairs, start = [], time.monotonic()
    while len(pairs) < options.pairs:
        if len(pairs) % 2 == 0:
            a = sample(old, row)
            b = sample(new, row, options.flags)
        else:
            b = sample(new, row, options.flags)
            a = sample(old, row)
        pairs.append((a, b))
        if options.seconds and time.monotonic() - start > options.seconds and len(pairs) >= 3:
            break
    return row, pairs


def main():
    options = arguments()
    os.makedirs(options.build, exist_ok=True)
    old, new = build(options, options.old, "gate_old"), build(options, options.new, "gate_new")
    rows = [(int(dim), kind, int(float(size)), int(threads)) for threads in options.threads.split(",")
            for dim in options.dims.split(",") for size in options.sizes.split(",")
            for kind in options.kinds.split(",")]
    alone = [row for row in rows if row[3] != 1]
    logs, over, failed = [], [], 0
    print(f"{'dim':>3} {'kind':12} {'points':>9} {'thr':>4} {'old':>10} {'new':>10} {'ratio':>6} {'best':>6} "
          f"{'spread':>13} {'B/pt old':>8} {'new':>6} pairs bytes")

    def show(result):
        nonlocal failed
        (dim, kind, size, threads), pairs = result
        ratios = sorted(b[0] / a[0] for a, b in pairs)
        ratio = statistics.median(ratios)
        best = min(b[0] for _, b in pairs) / min(a[0] for a, _ in pairs)
        same = len({x[2] for pair in pairs for x in pair}) == 1
        bytes_old, bytes_new = (statistics.median(pair[i][1] for pair in pairs) for i in (0, 1))
        logs.append(math.log(ratio))
        limit = LOOSE.get(kind, LOOSE.get(kind + str(dim), LIMIT))
        faults = ([f"ratio {ratio:.3f} over {limit}"] if ratio > limit else []) \
            + ([] if same else ["bytes differ"]) \
            + ([f"memory {bytes_new:.1f} over {bytes_old:.1f}"] if bytes_new > bytes_old * 1.005 + 0.5 else [])
        if faults:
            over.append(f"{dim}D {kind} {size} on {threads or 'all'}: " + ", ".join(faults))
        failed += not same
        print(f"{dim:>2}D {kind:12} {size:>9} {threads or 'all':>4} "
              f"{statistics.median(a[0] for a, _ in pairs):10.6f} {statistics.median(b[0] for _, b in pairs):10.6f} "
              f"{ratio:6.3f} {best:6.3f} {ratios[0]:6.3f}-{ratios[-1]:6.3f} {bytes_old:8.1f} {bytes_new:6.1f} {len(pairs):5} "
              f"{'same' if same else 'DIFFER'}", flush=True)

    with concurrent.futures.ThreadPoolExecutor(max(1, options.jobs)) as pool:
        for result in pool.map(lambda row: measure(options, old, new, row), [row for row in rows if row[3] == 1]):
            show(result)
    for row in alone:
        show(measure(options, old, new, row))
    mean = math.exp(sum(logs) / len(logs))
    print(f"geometric mean of {len(logs)} rows: {mean:.4f}")
    for line in over:
        print("over:", line)
    return 1 if over or failed or mean > 1.0 else 0


if __name__ == "__main__":
    sys.exit(main())
