#!/usr/bin/env python3
"""The beat compared with cyclictest: wake-up latency, execution time of a tick, time to the first pose.

    beat.py --bin DIRECTORY --drive DIRECTORY [--runs N] [--seconds S]

A run is two halves of S seconds. In the first, a real odomd plays a drive's log in real time with its
beat pinned to one CPU, and `cyclictest -m -i 5000` of the same priority runs pinned to another at
the same time; in the second the CPUs are swapped. A run's percentiles cover both halves, so that a
CPU that the host slows down affects both programs alike. Ratios are computed for each run.

Then odomd plays the same drive sixteen times as fast: 8,000 frames/s, all of mapped messages, so that
every frame is decoded, checked and fused.

odomd publishes a sample with every tick; all of them are read from its history, which is mapped read-only
and read once a second, so that watching does not affect the beat.
Both programs sleep until absolute times of CLOCK_MONOTONIC and keep the CPUs awake with
/dev/cpu_dma_latency. cyclictest rounds down to whole microseconds; odomd's samples are rounded down
here too.

Prints JSON.
"""

import argparse
import collections
import json
import math
import mmap
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time

PRIORITY = 45
PERIOD_US = 5000
FULL_TRAFFIC = 16
NOT_REALTIME = 1  # ODOM_COND_NOT_REALTIME
HEADER_BYTES, SLOT_BYTES, SLOTS, HEAD, POSE_WORDS = 1, 2, 16, 64, 28  # words of the segment: shm_api/layout/segment.h


def percentile(counts, fraction):
    """Percentile by nearest rank, of a histogram {value: count}."""
    rank = math.ceil(fraction * sum(counts.values()))
    for value in sorted(counts):
        rank -= counts[value]
        if rank <= 0:
            return value
    raise SystemExit("beat.py: no samples")


def summary(counts):
    percentiles = {name: percentile(counts, share) for name, share in (("p50", 0.5), ("p99", 0.99), ("p999", 0.999))}
    return {"samples": sum(counts.values()), **percentiles, "max": max(counts)}


def compress(log, factor, out):
    """The same frames, in a `factor`-th of the time. Stamps have six decimals."""
    first = None
    with open(log) as lines, open(out, "w") as faster:
        for line in lines:
            stamp, rest = line[1:].split(")", 1)
            stamp_us = int(stamp.replace(".", ""))
            first = stamp_us if first is None else first
            stamp_ns = first * 1000 + (stamp_us - first) * 1000 // factor
            faster.write(f"({stamp_ns // 10**9}.{stamp_ns % 10**9:09d}){rest}")


class Watcher(threading.Thread):
    """Collects every tick from a segment for so many seconds, beginning with the oldest in its history."""

    def __init__(self, path, seconds):
        super().__init__(daemon=True)
        with open(path, "rb") as file:
            self.words = memoryview(mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ)).cast("Q")
        self.seconds, self.ticks = seconds, []
        self.start()

    def run(self):
        for second in range(self.seconds + 1):
            time.sleep(min(second, 1))
            last = self.ticks[-1]["tick"] if self.ticks else 0
            read = (self.read(tick) for tick in range(last + 1, self.words[HEAD] // 2))
            self.ticks += filter(None, read)

    def read(self, tick):
        """A tick; nothing if it was missed or has been overwritten."""
        words = self.words
        at = (words[HEADER_BYTES] + tick % words[SLOTS] * words[SLOT_BYTES]) // 8
        slot = words[at:at + POSE_WORDS + 62].tolist()
        if words[at] != slot[0] or slot[0] != 2 * tick + 2:
            return None
        details = slot[1 + POSE_WORDS:]
        return {"tick": tick, "time_ns": slot[2], "mode": slot[24] & 0xFFFFFFFF, "conditions": slot[24] >> 32,
                "frames": details[50], "wakeup_latency_ns": details[59], "execution_of_last_ns": details[60]}


class Daemon:
    """An odomd that plays a log with its beat on one CPU, and what a watcher sees of it."""

    def __init__(self, args, log, cpu, work, seconds):
        self.segment = work / "pose"
        config = work / "car.toml"
        car = (args.drive / "car.toml").read_text().replace("car.dbc", f"{args.drive}/car.dbc")
        config.write_text(f"{car}\n[realtime]\npriority = {PRIORITY}\ncpu = {cpu}\n")
        command = [args.bin / "odomd", "--config", config, "--can", log, "--initial", "0,0,0"]
        command += ["--runtime-directory", work, "--log-level", "error"]
        self.exec_ns = time.monotonic_ns()
        self.process = subprocess.Popen(command)
        while not self.segment.exists():
            if self.process.poll() is not None:
                raise SystemExit("beat.py: odomd ended")
            time.sleep(0.01)
        self.watcher = Watcher(self.segment, seconds)

    def ticks(self):
        """Waits for the watcher, ends the daemon, and gives every tick as a dictionary."""
        self.watcher.join()
        self.process.send_signal(signal.SIGTERM)
        if self.process.wait() != 0:
            raise SystemExit("beat.py: odomd failed")
        self.segment.unlink()
        ticks = self.watcher.ticks
        if any(tick["conditions"] & NOT_REALTIME for tick in ticks):
            raise SystemExit("beat.py: odomd was refused SCHED_FIFO or locked memory: run as root")
        return ticks


def executions(ticks):
    """Histogram of the ticks' execution times [µs]; a tick's time is published with the next tick."""
    return collections.Counter(round(tick["execution_of_last_ns"] / 1000, 1) for tick in ticks[1:])


def first_pose_ms(ticks, exec_ns):
    """Time [ms] from exec until a pose with a mode other than `initialising` can be read."""
    first = next(i for i, tick in enumerate(ticks) if tick["mode"] != 0)
    woke_ns = ticks[first]["time_ns"] + ticks[first]["wakeup_latency_ns"]
    return (woke_ns + ticks[first + 1]["execution_of_last_ns"] - exec_ns) / 1e6


def skipped(ticks):
    return ticks[-1]["tick"] - ticks[0]["tick"] + 1 - len(ticks)


def with_cyclictest(args, cpus, work):
    """Half a run: odomd on cpus[0], cyclictest on cpus[1]."""
    daemon = Daemon(args, args.drive / "drive.log", cpus[0], work, args.seconds + 2)
    time.sleep(0.5)
    report = work / "cyclictest.json"
    begin_ns = time.monotonic_ns()
    subprocess.run(f"cyclictest -q -m -p {PRIORITY} -i {PERIOD_US} -t 1 -a {cpus[1]} -D {args.seconds} "
                   f"-h 1000000 --json={report}".split(), check=True, stdout=subprocess.DEVNULL)
    end_ns = time.monotonic_ns()
    ticks = daemon.ticks()
    during = [tick for tick in ticks if begin_ns <= tick["time_ns"] < end_ns]
    thread = json.loads(report.read_text())["thread"]["0"]
    return {
        "odomd": collections.Counter(tick["wakeup_latency_ns"] // 1000 for tick in during),
        "cyclictest": collections.Counter({int(value): count for value, count in thread["histogram"].items()}),
        "execution": executions(during),
        "skipped": skipped(during),
        "first_pose_ms": first_pose_ms(ticks, daemon.exec_ns),
    }


def run_with_cyclictest(args, cpus, work):
    halves = [with_cyclictest(args, order, work) for order in (cpus, cpus[::-1])]
    run = {key: summary(halves[0][key] + halves[1][key]) for key in ("odomd", "cyclictest", "execution")}
    run["ratio"] = {key: run["odomd"][key] / run["cyclictest"][key] for key in run["odomd"]}
    run["skipped"] = sum(half["skipped"] for half in halves)
    run["first_pose_ms"] = max(half["first_pose_ms"] for half in halves)
    return run


def run_full_traffic(args, log, cpu, work):
    seconds = max(3, args.seconds // 3)
    ticks = Daemon(args, log, cpu, work, seconds).ticks()[200:]
    frames = ticks[-1]["frames"] - ticks[0]["frames"]
    return {
        "execution": summary(executions(ticks)),
        "frames_per_s": frames * 1e9 / (ticks[-1]["time_ns"] - ticks[0]["time_ns"]),
        "skipped": skipped(ticks),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--drive", type=pathlib.Path, required=True)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--seconds", type=int, default=15)
    args = parser.parse_args()
    args.drive = args.drive.resolve()

    cpus = sorted(os.sched_getaffinity(0))[-2:]
    if len(cpus) < 2:
        raise SystemExit("beat.py: needs two CPUs, one for odomd and one for cyclictest")
    with tempfile.TemporaryDirectory(dir="/dev/shm", prefix="odomd-bench-") as directory:
        work = pathlib.Path(directory)
        full = work / "full.log"
        compress(args.drive / "drive.log", FULL_TRAFFIC, full)
        result = {"cpus": cpus, "priority": PRIORITY, "seconds_per_half": args.seconds}
        result["nominal"] = [run_with_cyclictest(args, cpus, work) for _ in range(args.runs)]
        result["full"] = [run_full_traffic(args, full, cpus[0], work) for _ in range(args.runs)]
    json.dump(result, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
