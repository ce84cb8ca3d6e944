#!/usr/bin/env python3
"""Checks that the source flags show what fails, and nothing else: every scenario of odom sim, many seeds.

Each drive is replayed once as it is (no flag may be raised, except for slipping wheels on ice), and once for
every fault in the table of source_flags.hpp, from the same random time on: the flag of that source must be raised
within 0.5 s after the fault shows, and before any other source's.
Standard output is a table in Markdown. Exit status 1 if a flag is missed, late or false, or the work failed; 2
on wrong usage.
"""

import json
import statistics
import sys

import common

SCENARIOS = ("lap", "circle", "slalom", "stop-and-go", "parking", "patch", "road")
SLIPPERY = ("patch",)  # wheels slip without a fault
LIMIT = 0.5  # s
STEP = 0.005  # s per tick: a flag appears at the end of its tick


def arguments():
    parser = common.parser(__doc__, seeds=20, work=True, programs=("odom", "fault_runs"))
    parser.add_argument("--scenario", action="append", choices=SCENARIOS, help="this one; several times: these")
    parser.add_argument("--verbose", action="store_true", help="name every fault that was missed or late")
    return common.parse(parser)


def raised(flags):
    return [flag for flag in flags if flag[2] != "ok"]


def judge(fault, known):
    """Returns the fault with three results: the delay of its flag [s], or None; whether the flag is late or missed; and
    the earlier flags of other sources. `known`: the flags of the drive without fault, which do not count."""
    flags = raised(fault["flags"])
    own = [t for t, source, _ in flags if source == fault["source"] and t >= fault["begin"]]
    shown, until = fault["shown"], own[0] if own else float("inf")
    others = [flag for flag in flags
              if flag[1] != fault["source"] and fault["begin"] <= flag[0] < until and flag not in known]
    delay = max(0.0, own[0] - shown) if own and shown is not None else None
    return {**fault, "delay": delay, "late": delay is not None and delay > LIMIT + STEP,
            "missed": shown is not None and not own, "others": others if shown is not None or not own else []}


def measure(given, scenario, seed, folder):
    """Returns a drive's scenario and name, its flags without a fault, and its judged faults. Every second drive has a
    camera."""
    lines = common.output(given.bin / "fault_runs", folder, seed, "--flags", "--camera", "on" if seed % 2 else "off")
    as_it_is, *faults = map(json.loads, lines.splitlines())
    flags = raised(as_it_is["flags"])
    return scenario, f"{scenario}, seed {seed}", flags, [judge(fault, flags) for fault in faults]


def name_trouble(name, fault):
    what = f"{name}: {fault['kind']} at {fault['begin']:.2f} s"
    if fault["others"]:
        t, source, flag = fault["others"][0]
        print(f"{what}: {source} {flag} at {t:.2f} s", file=sys.stderr)
    delay = fault["delay"]
    if fault["missed"] or fault["late"]:
        print(f"{what}, shown at {fault['shown']:.2f} s: "
              f"{'missed' if fault['missed'] else f'after {delay:.2f} s'}", file=sys.stderr)


def main():
    given = arguments()
    scenarios = given.scenario or SCENARIOS
    tasks = [(scenario, ("--scenario", scenario), seed) for scenario in scenarios for seed in range(1, given.seeds + 1)]
    drives = common.each_drive(given, tasks, lambda scenario, seed, folder, _: measure(given, scenario, seed, folder))

    good = True
    print(f"Source flags, {common.BEGUN:%F}: {given.seeds} drives of each of "
          f"{len(scenarios)} scenarios, every second one with a camera.\n")
    print("| drives as they are | drives | false flags | wheels flagged as slipping |")
    print("|---|--:|--:|--:|")
    for scenario in scenarios:
        flags = [(name, flag) for of, name, flags, _ in drives if of == scenario for flag in flags]
        slips = [flag for _, flag in flags if flag[2] == "slipping"]
        false = [(name, flag) for name, flag in flags if flag[2] != "slipping" or scenario not in SLIPPERY]
        for name, (t, source, flag) in false:
            print(f"{name}: {source} {flag} at {t:.2f} s", file=sys.stderr)
        good = good and not false
        print(f"| {scenario} | {given.seeds} | {len(false)} | {len(slips)} |")

    by_kind = {}
    for _, name, _, faults in drives:
        for fault in faults:
            by_kind.setdefault(fault["kind"], []).append(fault)
            if given.verbose:
                name_trouble(name, fault)
    print("\n| fault | faults that show | median [s] | latest [s] | late | missed | others flagged |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    for kind, faults in by_kind.items():
        shown = sum(fault["shown"] is not None for fault in faults)
        delays = [fault["delay"] for fault in faults if fault["delay"] is not None] or [float("nan")]
        late, missed, others = (sum(bool(fault[key]) for fault in faults) for key in ("late", "missed", "others"))
        good = good and not late + missed + others
        print(f"| {kind} | {shown} of {len(faults)} | {statistics.median(delays):.3f} | {max(delays):.3f} | "
              f"{late} | {missed} | {others} |")
    return 0 if good else 1


if __name__ == "__main__":
    common.main(main)
