#!/usr/bin/env python3
"""How odom tune scales with cores: the same sweep by 1, 2, ... jobs, medians of several rounds.

    python3 tests/campaign/tune_scaling.py [--rounds 5] [--bin build/release/bin]

The jobs take turns within a round, so that a busy machine hits them alike. Exit status 1 where as many jobs as cores
are not at least 0.7 times as many times faster.
"""
import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--bin", type=pathlib.Path, default=pathlib.Path("build/release/bin"))
    options = parser.parse_args()
    odom = str(options.bin.resolve() / "odom")
    cores = len(os.sched_getaffinity(0))
    jobs = sorted({1, 2, cores} - {n for n in (1, 2) if n > cores})
    times: dict[int, list[float]] = {n: [] for n in jobs}
    results = set()
    with tempfile.TemporaryDirectory() as folder:
        drives = []
        for seed in range(1, 5):
            drive = f"{folder}/{seed}"
            subprocess.run([odom, "sim", "--scenario", "lap", "--duration", "60", "--seed", str(seed), "--out", drive],
                           check=True, capture_output=True)
            drives += ["--drive", drive]
        for _ in range(options.rounds):
            for n in jobs:
                begin = time.monotonic()
                done = subprocess.run([odom, "tune", *drives, "--set", "filter.front_angle_error=0.02:0.5:8",
                                       "--jobs", str(n), "--json"], check=True, capture_output=True, text=True)
                times[n].append(time.monotonic() - begin)
                results.add(done.stdout)
    print(f"{cores} cores, {options.rounds} rounds; 4 drives of 60 s, 8 values\n\n| jobs | median s | times faster |\n|---|---|---|")
    one = statistics.median(times[1])
    for n in jobs:
        print(f"| {n} | {statistics.median(times[n]):.2f} | {one / statistics.median(times[n]):.2f} |")
    if len(results) != 1:
        print("the results differ", file=sys.stderr)
        return 1
    speedup = one / statistics.median(times[cores])
    return 0 if speedup >= 0.7 * cores else 1


if __name__ == "__main__":
    sys.exit(main())
