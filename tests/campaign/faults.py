#!/usr/bin/env python3
"""Checks that the source flags show what fails, and nothing else: every scenario of odom sim, many seeds.

Each drive is replayed once as it is (no flag may be raised, except for slipping wheels on ice), and once for
every fault in the table of source_flags.hpp, from the same random time on: the flag of that source must be raised
within 0.5 s after the fault shows, and before any other source's.
Standard output is a table in Markdown. Exit status 1 if a flag is missed, late or false, or the work failed; 2
on wrong usage.
"""

import collections
import datetime
import json
import pathlib
import statistics
import sys
import tempfile

import common

SCENARIOS = ("lap", "circle", "slalom", "stop-and-go", "parking", "patch", "road")
SLIPPERY = ("patch",)  # wheels really slip
LIMIT = 0.5  # s
STEP = 0.005  # s per tick: a flag appears at the end of its tick


def arguments():
    parser = common.parser(__doc__, seeds=20, odom=False)
    parser.add_argument("--scenario", action="append", choices=SCENARIOS, help="this one; several times: these")
    parser.add_argument("--bin", type=pathlib.Path, default=common.ROOT / "build/release", metavar="DIR",
                        help="the build; default: build/release")
    parser.add_argument("--verbose", action="store_true", help="name every fault that was missed or late")
    return common.parse(parser)


def measure(build, scenario, seed):
    """The lines of fault_runs --flags for a drive, the first of them for the drive without fault. Every second drive
    has a camera."""
    with tempfile.TemporaryDirectory(prefix="faults-") as scratch:
        folder = pathlib.Path(scratch) / "drive"
        common.run(build / "bin/odom", "sim", "--scenario", scenario, "--seed", seed, "--out", folder)
        lines = common.output(build / "bin/fault_runs", folder, seed, "--flags", "--camera",
                              "on" if seed % 2 else "off")
        return scenario, seed, [json.loads(line) for line in lines.splitlines()]


def raised(flags):
    return [flag for flag in flags if flag[2] != "ok"]


def judge(fault, known):
    """Delay of the flag in s, None if it is missed; and the flags of other sources that came before it. `known`
    are the flags of the drive without fault, which do not count."""
    own = [t for t, source, _ in raised(fault["flags"]) if source == fault["source"] and t >= fault["begin"]]
    until = own[0] if own else float("inf")
    others = [flag for flag in raised(fault["flags"])
              if flag[1] != fault["source"] and flag[0] < until and flag[0] >= fault["begin"] and flag not in known]
    if fault["shown"] is None:
        return None, others if not own else []
    return (max(0.0, own[0] - fault["shown"]) if own else None), others


def main():
    given = arguments()
    scenarios = given.scenario or SCENARIOS
    results = common.side_by_side(given.jobs, measure, [(given.bin, scenario, seed) for scenario in scenarios
                                                        for seed in range(1, given.seeds + 1)])

    good = True
    print(f"Source flags, {datetime.date.today()}: {given.seeds} drives of each of "
          f"{len(scenarios)} scenarios, every second one with a camera.\n")
    print("| drives as they are | drives | false flags | wheels flagged as slipping |")
    print("|---|--:|--:|--:|")
    for scenario in scenarios:
        drives = [(seed, raised(lines[0]["flags"])) for name, seed, lines in results if name == scenario]
        slips = [flag for _, flags in drives for flag in flags if flag[2] == "slipping"]
        false = [(seed, flag) for seed, flags in drives for flag in flags
                 if flag[2] != "slipping" or scenario not in SLIPPERY]
        for seed, flag in false:
            print(f"{scenario}, seed {seed}: {flag[1]} {flag[2]} at {flag[0]:.2f} s", file=sys.stderr)
        good = good and not false
        print(f"| {scenario} | {len(drives)} | {len(false)} | {len(slips)} |")

    rows = collections.defaultdict(lambda: {"shown": 0, "delays": [], "missed": 0, "late": 0, "others": 0, "hidden": 0})
    for scenario, seed, lines in results:
        for fault in lines[1:]:
            delay, others = judge(fault, lines[0]["flags"])
            row = rows[fault["kind"]]
            row["others"] += bool(others)
            label = f"{scenario}, seed {seed}: {fault['kind']} at {fault['begin']:.2f} s"
            if others and given.verbose:
                print(f"{label}: {others[0][1]} {others[0][2]} at {others[0][0]:.2f} s", file=sys.stderr)
            if fault["shown"] is None:
                row["hidden"] += 1
                continue
            row["shown"] += 1
            if delay is None:
                row["missed"] += 1
            else:
                row["delays"].append(delay)
                row["late"] += delay > LIMIT + STEP
            if given.verbose and (delay is None or delay > LIMIT + STEP):
                print(f"{label}, shown at {fault['shown']:.2f} s: "
                      f"{'missed' if delay is None else f'after {delay:.2f} s'}", file=sys.stderr)
    print("\n| fault | faults that show | median [s] | latest [s] | late | missed | others flagged |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    for kind, row in rows.items():
        delays = row["delays"] or [float("nan")]
        good = good and not row["late"] and not row["missed"] and not row["others"]
        print(f"| {kind} | {row['shown']} of {row['shown'] + row['hidden']} | {statistics.median(delays):.3f} | "
              f"{max(delays):.3f} | {row['late']} | {row['missed']} | {row['others']} |")
    return 0 if good else 1


if __name__ == "__main__":
    common.main(main)
