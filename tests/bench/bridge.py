#!/usr/bin/env python3
"""The cost of a running bridge: the beat with and without it, and the bridge's own CPU time.

    bridge.py --bin DIRECTORY [--runs N] [--seconds S]

A run is two halves of S seconds, in alternating order: odomd plays a simulated lap in real time, in one half
alone, in the other together with an odom bridge that sends every tick by DDS (over the loopback) and by UDP,
where nobody listens. The beat's percentiles are those of odomd's own status. Needs root, or limits that permit
SCHED_FIFO, and a quiet machine. Prints Markdown.
"""

import argparse
import json
import os
import pathlib
import signal
import statistics
import subprocess
import tempfile
import time

LOOPBACK = ('<General><Interfaces><NetworkInterface name="lo"/></Interfaces>'
            "<AllowMulticast>false</AllowMulticast></General>")
FIGURES = [(part, name) for part in ("wakeup_us", "execution_us") for name in ("p50", "p99", "max")]


def wait_for(path):
    until = time.monotonic() + 60
    while not path.exists():
        if time.monotonic() > until:
            raise SystemExit(f"bridge.py: {path} does not appear")
        time.sleep(0.01)


def half(args, work, with_bridge):
    """The beat's figures; the bridge's share of a CPU, and its summary."""
    status = work / "status.sock"
    command = [args.bin / "odomd", "--config", work / "drive/car.toml", "--can", work / "drive/drive.log"]
    command += ["--initial", "0,0,0", "--runtime-directory", work, "--log-level", "error"]
    daemon = subprocess.Popen(command)
    wait_for(status)
    share, said = 0.0, {}
    if with_bridge:
        bridge = [args.bin / "odom", "bridge", "--ros", "--udp", "127.0.0.1:9", "--rate", "1000", "--json"]
        bridge += ["--shm", work / "pose", "--domain", "99"]
        environment = dict(os.environ, CYCLONEDDS_URI=LOOPBACK)
        begin = time.monotonic()
        with open(work / "bridge.json", "w") as out:
            process = subprocess.Popen(bridge, stdout=out, env=environment)
        time.sleep(args.seconds)
        process.send_signal(signal.SIGTERM)
        _, result, usage = os.wait4(process.pid, 0)
        if result != 0:
            raise SystemExit("bridge.py: odom bridge failed")
        share = (usage.ru_utime + usage.ru_stime) / (time.monotonic() - begin)
        said = json.loads((work / "bridge.json").read_text())
    else:
        time.sleep(args.seconds)
    answer = subprocess.run([args.bin / "odom", "status", "--json", "--socket", status], check=True, capture_output=True)
    daemon.send_signal(signal.SIGTERM)
    daemon.wait()
    beat = json.loads(answer.stdout)["beat"]
    return {**{(part, name): beat[part][name] for part, name in FIGURES}, "missed": beat["missed"],
            "share": share, "said": said}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=10.0)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir="/dev/shm", prefix="odomd-bench-") as directory:
        work = pathlib.Path(directory)
        subprocess.run([args.bin / "odom", "sim", "--duration", str(args.seconds + 10), "--out", work / "drive"],
                       check=True, stdout=subprocess.DEVNULL)
        alone, bridged = [], []
        for run in range(args.runs):
            for with_bridge in (False, True) if run % 2 == 0 else (True, False):
                (bridged if with_bridge else alone).append(half(args, work, with_bridge))

    def median(halves, key):
        return statistics.median(one[key] for one in halves)

    load = os.getloadavg()[0]
    print(f"Medians of {args.runs} runs of {args.seconds:.0f} s; load average {load:.1f} on {os.cpu_count()} CPUs\n")
    print("| | alone | with a bridge |\n|---|---|---|")
    for part, name in FIGURES:
        row = (median(alone, (part, name)), median(bridged, (part, name)))
        print(f"| {part.removesuffix('_us')}, {name} | {row[0]:.0f} µs | {row[1]:.0f} µs |")
    print(f"| ticks missed, all runs | {sum(o['missed'] for o in alone)} | {sum(o['missed'] for o in bridged)} |")
    ticks, lost = (sum(one["said"][key] for one in bridged) for key in ("ticks", "lost"))
    dds = sum(one["said"]["sinks"][0]["sent"] for one in bridged)
    print(f"| the bridge's share of a CPU | | {100 * median(bridged, 'share'):.1f} % |")
    print(f"| ticks followed, lost, sent by DDS | | {ticks}, {lost}, {dds} |")


if __name__ == "__main__":
    main()
