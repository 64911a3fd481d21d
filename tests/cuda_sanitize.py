#!/usr/bin/env python3
"""cuda_sanitize.py PROGRAM: all of tests/cuda_test.c under compute-sanitizer, in parts that run side by side.

    make cuda-sanitize ARGS='--tools racecheck --seconds 550'

Alone the suite takes hours.  So its parts run as processes of their own on each device, through MPS
(nvidia-cuda-mps-control), which lets their kernels run at the same time; an access that is not allowed ends all
processes of that device.  With --jobs 1 there is no MPS.  Where processes share a device, initcheck reports errors that
are not there, even for threads whose streams share nothing: run parts that have errors again with --jobs 1.

Tests that need all memory of a device, or time themselves, run after the parts, alone.  Under racecheck, whose workers
keep all cores busy, these are skipped, and large tests take a twentieth of their points or builds or less, as some take
ten minutes with all: it finds races between threads of a block, and more points mostly add blocks.

Writes the output of each part to FOLDER/TOOL-PART.log, and prints, for each tool, the parts that had errors or did
not end in time: give them to --only next time.  The last line is `N passed, N failed, N skipped`; exit status 1: a
test failed, the tool found an error, or a part did not end.
"""
import argparse
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import threading
import time

FLAGS = {"memcheck": ["--leak-check", "full"], "racecheck": [], "initcheck": [], "synccheck": []}
SETTINGS = {"initcheck": {"CUDA_TEST_LEAVE": "1"}, "racecheck": {"CUDA_TEST_FEWER": "1"}}
ALONE = ["too little device memory", "loop: memory", "cancelled soon"]
EXPECTED = {("memcheck", ALONE[0]): ["--report-api-errors", "no"]}      # its allocations fail, and must


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--tools", default=",".join(FLAGS))
    parser.add_argument("--options", default="", help="more options of compute-sanitizer")
    parser.add_argument("--count", default="20")
    parser.add_argument("--parts", type=int, default=96)
    parser.add_argument("--only", default="", help="these parts, such as 1-43,57,alone")
    parser.add_argument("--devices", type=int, default=0, help="0: all")
    parser.add_argument("--jobs", type=int, default=16, help="processes on a device")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="ends what still runs after so long")
    parser.add_argument("--folder", default="build/cuda_sanitize")
    return parser.parse_args()


def numbers(text, most):
    for span in [span for span in text.split(",") if span != "alone"] if text else [f"1-{most}"]:
        first, _, last = span.partition("-")
        yield from range(int(first), int(last or first) + 1)


class Runs:
    def __init__(self, options):
        self.options, self.end, self.lock = options, time.monotonic() + options.seconds, threading.Lock()
        self.counts, self.bad, self.late = [0, 0, 0], {}, {}

    def run(self, tool, name, arguments, environment):
        """Runs some tests under a tool, and notes what came of it."""
        path = os.path.join(self.options.folder, f"{tool}-{name.replace(' ', '_')}.log")
        command = ["compute-sanitizer", "--tool", tool, "--error-exitcode", "9", *FLAGS[tool],
                   *EXPECTED.get((tool, name), []), *self.options.options.split(), self.options.program,
                   "--count", self.options.count, *arguments]
        began = time.monotonic()
        left, late = self.end - began, True
        if left > 0:
            with open(path, "w") as log:
                child = subprocess.Popen(command, env={**environment, **SETTINGS.get(tool, {})}, stdout=log,
                                         stderr=log, start_new_session=True)
                try:
                    child.wait(None if left == float("inf") else left)
                    late = False
                except subprocess.TimeoutExpired:
                    os.killpg(child.pid, signal.SIGKILL)
                    child.wait()
        with self.lock:
            if late:
                self.late.setdefault(tool, []).append(name)
                return
            with open(path, errors="replace") as log:
                found = re.findall(r"^(\d+) passed, (\d+) failed, (\d+) skipped", log.read(), re.MULTILINE)
            for i in range(3):
                self.counts[i] += int(found[-1][i]) if found else 0
            good = child.returncode == 0 and found
            print(f"{tool} {name}: {'no errors' if good else 'ERRORS'}, {time.monotonic() - began:.0f} s", flush=True)
            if not good:
                self.bad.setdefault(tool, []).append(name)

    def serve(self, waiting, environment):
        """Takes parts from the queue until it is empty."""
        without = [word for test in ALONE for word in ("--without", test)]
        while True:
            try:
                tool, part = waiting.get_nowait()
            except queue.Empty:
                return
            self.run(tool, str(part), [*without, "--part", f"{part}/{self.options.parts}"], environment)

    def use_device(self, device, waiting):
        """Runs parts on a device, by an MPS server of its own or one by one."""
        if self.options.jobs == 1:
            self.serve(waiting, dict(os.environ, CUDA_VISIBLE_DEVICES=str(device)))
            return
        folder = os.path.abspath(os.path.join(self.options.folder, f"device{device}"))
        os.makedirs(folder, exist_ok=True)
        environment = dict(os.environ, CUDA_MPS_PIPE_DIRECTORY=folder, CUDA_MPS_LOG_DIRECTORY=folder)
        subprocess.run(["nvidia-cuda-mps-control", "-d"], env=dict(environment, CUDA_VISIBLE_DEVICES=str(device)),
                       check=True)
        threads = [threading.Thread(target=self.serve, args=(waiting, environment)) for _ in range(self.options.jobs)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        subprocess.run(["nvidia-cuda-mps-control"], input="quit\n", text=True, env=environment, check=True)


def main():
    options = arguments()
    for program in ["nvidia-smi", "compute-sanitizer"] + ["nvidia-cuda-mps-control"] * (options.jobs > 1):
        if shutil.which(program) is None:
            print(f"skipped: no {program}\n0 passed, 0 failed, 1 skipped")
            return 0
    listed = subprocess.run(["nvidia-smi", "-L"], check=True, capture_output=True, text=True).stdout
    runs, waiting = Runs(options), queue.Queue()
    tools = options.tools.split(",")
    os.makedirs(options.folder, exist_ok=True)
    for tool in tools:
        for part in numbers(options.only, options.parts):
            waiting.put((tool, part))
    devices = [threading.Thread(target=runs.use_device, args=(device, waiting))
               for device in range(options.devices or len(listed.splitlines()))]
    for device in devices:
        device.start()
    for device in devices:
        device.join()
    while not waiting.empty():                       # a device whose server did not start takes none
        tool, part = waiting.get()
        runs.late.setdefault(tool, []).append(str(part))
    for tool in tools if not options.only or "alone" in options.only else []:
        for test in ALONE if tool != "racecheck" else []:
            runs.run(tool, test, ["--filter", test], dict(os.environ))
        runs.counts[2] += len(ALONE) if tool == "racecheck" else 0
    for tool in tools:
        print(f"{tool}: with errors: {', '.join(runs.bad.get(tool, [])) or 'none'};"
              f" not ended: {', '.join(runs.late.get(tool, [])) or 'none'}")
    print("{} passed, {} failed, {} skipped".format(*runs.counts))
    return 1 if runs.bad or runs.late else 0


if __name__ == "__main__":
    sys.exit(main())
