#!/usr/bin/env python3
"""The results of the benchmarks as one table in Markdown: report.py DIRECTORY

DIRECTORY holds what run.sh has collected: bench_*.json (Google Benchmark), beat.json (beat.py),
replay-*.txt (the drive's length in s, then how long each replay took, in ns). Every figure is a median of the
repetitions. Times of single threads are CPU times, so that a neighbour on the machine does not count.
"""

import argparse
import json
import os
import pathlib
import platform
import statistics
import subprocess


class Report:
    def __init__(self):
        self.rows = []

    def row(self, what, value, unit, peer=None, peer_value=None, ratio=None, bar=None):
        """`ratio` defaults to value / peer_value. `bar` is a key of BARS and the limit."""
        if ratio is None and peer_value is not None:
            ratio = value / peer_value
        kind, limit = bar or (None, None)
        met = BARS[kind](value, ratio, limit) if kind else None
        self.rows.append({"what": what, "value": value, "unit": unit, "peer": peer, "peer_value": peer_value,
                          "ratio": ratio, "bar": kind, "limit": limit, "met": met})

    def markdown(self):
        yield "| what | measured | compared with | ratio | limit | met |"
        yield "|---|--:|--:|--:|--:|---|"
        for row in self.rows:
            peer = f"{row['peer']}: {number(row['peer_value'])}" if row["peer"] else ""
            ratio = "" if row["ratio"] is None else fraction(row["ratio"])
            bar = f"{row['bar']} {row['limit']:,}" if row["bar"] else ""
            met = {True: "yes", False: "**no**", None: ""}[row["met"]]
            measured = f"{number(row['value'])} {row['unit']}"
            yield f"| {row['what']} | {measured} | {peer} | {ratio} | {bar} | {met} |"


BARS = {
    "≤": lambda value, ratio, limit: value <= limit,
    "≥": lambda value, ratio, limit: value >= limit,
    "ratio ≤": lambda value, ratio, limit: ratio <= limit,
    "times faster ≥": lambda value, ratio, limit: 1 / ratio >= limit,
}


def number(value):
    """About three significant digits."""
    if value >= 100 or value == round(value):
        return f"{value:,.0f}"
    return f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def fraction(ratio):
    return number(ratio) if ratio >= 0.5 else f"1/{number(1 / ratio)}"


class Benchmarks:
    """The medians of Google Benchmark's repetitions, by name of the benchmark."""

    def __init__(self, directory):
        self.medians = {}
        for file in sorted(directory.glob("bench_*.json")):
            for entry in json.loads(file.read_text())["benchmarks"]:
                if entry["aggregate_name"] == "median":
                    self.medians[entry["run_name"].partition("/iterations")[0]] = entry

    def __contains__(self, name):
        return name in self.medians

    def cpu_ns(self, name):
        return self.medians[name]["cpu_time"]

    def counter_ns(self, name, counter="p50_ns"):
        """A median that the benchmark itself has computed."""
        return self.medians[name][counter]

    def fresh_ns(self, name):
        """Median of single reads, without the two clock readings around each."""
        return self.counter_ns(name) - self.counter_ns("nothing_fresh")


def median(runs, *path):
    def at(run):
        for key in path:
            run = run[key]
        return run

    return statistics.median(at(run) for run in runs)


def add_beat(report, beat):
    nominal, full = beat["nominal"], beat["full"]
    for key, name, bar in (("p50", "median", None), ("p99", "p99", None),
                           ("p999", "p99.9", ("ratio ≤", 1.5)), ("max", "max", None)):
        report.row(f"wake-up latency, {name}", median(nominal, "odomd", key), "µs", "cyclictest",
                   median(nominal, "cyclictest", key), median(nominal, "ratio", key), bar)
    for traffic, runs in (("nominal traffic, 500 frames/s", nominal),
                          (f"full traffic, {median(full, 'frames_per_s'):,.0f} frames/s", full)):
        for key, name in (("p50", "median"), ("p99", "p99"), ("max", "max")):
            report.row(f"tick, {traffic}: {name}", median(runs, "execution", key), "µs")
    report.row("exec to first valid pose, slower of two starts",
               median(nominal, "first_pose_ms"), "ms", bar=("≤", 150))


def add_pose(report, bench):
    for kind, suffix, of, of_take in (
        ("hot", "", bench.cpu_ns, bench.counter_ns),
        ("freshly written", "_fresh", bench.fresh_ns, bench.fresh_ns),
    ):
        latest, what = of("latest" + suffix), f"read a pose, {kind}"
        in_place, what_in_place = of("in_place" + suffix), f"read three values in place, {kind}"
        report.row(what, latest, "ns", "relaxed copy", of("copy_relaxed_words" + suffix),
                   bar=("ratio ≤", 3))
        if suffix:
            report.row(what, latest, "ns", "memcpy", of("copy_memcpy" + suffix))
        if "iceoryx_hot" in bench:
            take = of_take("iceoryx" + (suffix or "_hot"))
            report.row(what, latest, "ns", "iceoryx take", take, bar=("times faster ≥", 8))
            report.row(what_in_place, in_place, "ns", "iceoryx take", take)
        else:
            report.row(what_in_place, in_place, "ns")
    if "iceoryx_hot" in bench:
        report.row("publish a pose with its details and their checksum", bench.cpu_ns("publish"), "ns",
                   "iceoryx loan + publish", bench.counter_ns("iceoryx_hot", "publish_ns"))


def add_work(report, bench):
    author, elsewhere = ("author's code", 575.0), "robot_localization"
    for name, what, limit, *peer in (
        ("decode_unmapped", "decode an unmapped frame", 50),
        ("decode_three_signals", "decode a frame, three signals", 50),
        ("decode_three_signals_protected", "decode a protected frame (profile 1), three signals", 50),
        ("paper_predict_and_correct", "paper filter, predict and correct", 57, *author),
        ("whole_tick/paper", "paper, whole tick with its samples", None),
        ("camera_pose", "paper, tick with a camera pose 40 ms late", None),
        ("full_tick/0", "full, whole tick with its samples", 5_000, elsewhere, 11_600.0),
        ("full_tick_late_camera/40", "full, tick with a camera pose 40 ms late", 40_000,
         elsewhere, 78_000.0),
        ("full_tick_late_wheel/249", "full, tick with the longest rewind, 250 ms", 250_000),
    ):
        report.row(what, bench.cpu_ns(name), "ns", *peer, bar=limit and ("≤", limit))


def add_replay(report, directory):
    for model, camera, limit in (("paper", "", 2000), ("full", " --camera", 300)):
        length_s, *times_ns = map(int, (directory / f"replay-{model}.txt").read_text().split())
        report.row(f"replay of a drive, `--model {model}{camera}`", length_s * 1e9 / statistics.median(times_ns),
                   "times real time", bar=("≥", limit))


def output_of(*command):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()
    except OSError:
        return ""


def machine():
    with open("/proc/cpuinfo") as file:
        model = next((line.split(":")[1].strip() for line in file if line.startswith("model name")), "")
    governor = pathlib.Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")
    virtual = output_of("systemd-detect-virt", "--vm")
    return {
        "cpu": f"{os.cpu_count()} x {model or platform.machine()}",
        "virtual": "no" if virtual in ("", "none") else virtual,
        "kernel": f"{platform.release()} {platform.version()}",
        "governor": governor.read_text().strip() if governor.exists() else "not shown by this machine",
        "compiler": output_of("c++", "--version").splitlines()[0],
        "date": output_of("date", "-u", "+%F %R UTC"),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directory", type=pathlib.Path)
    args = parser.parse_args()

    beat = json.loads((args.directory / "beat.json").read_text())
    host = machine() | {"load_before": (args.directory / "load").read_text().strip()}
    bench = Benchmarks(args.directory)
    report = Report()
    add_beat(report, beat)
    add_pose(report, bench)
    add_work(report, bench)
    add_replay(report, args.directory)

    print(f"{host['date']}; {host['cpu']}, virtual: {host['virtual']}; kernel {host['kernel']}; "
          f"frequency governor: {host['governor']}; {host['compiler']}; load before: "
          f"{host['load_before']}; {len(beat['nominal'])} runs of 2 x {beat['seconds_per_half']} s, "
          f"CPUs {beat['cpus'][0]} and {beat['cpus'][1]} swapped.")
    print()
    print("\n".join(report.markdown()))
    missed = sum(run["skipped"] for run in beat["nominal"]), sum(run["skipped"] for run in beat["full"])
    print(f"\nCycles missed by odomd: {missed[0]} under nominal, {missed[1]} under full traffic.")
    if float(host["load_before"].split()[0]) > 1:
        print("The machine was busy before the run: the ratios are more reliable than the times.")
    if "iceoryx_hot" not in bench:
        print("iceoryx is not installed: its rows are missing.")


if __name__ == "__main__":
    main()
