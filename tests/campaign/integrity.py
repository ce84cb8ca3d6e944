#!/usr/bin/env python3
"""Checks whether odomd ever publishes a wrong pose in silence: every kind of fault on simulated drives.

Each drive is replayed as it is, and once for every kind of fault, with its camera and without. A pose is
silent if it is off by more than five of its own standard deviations, with no condition set and in the mode of
a good pose; and gross if it is also off by more than 0.1 m or 0.1 rad. The bars, for each kind:

  silent      without a camera silent for more than 0.5 s, with one gross for more than 0.5 s:
              in at most 2 % of the runs; without a fault in none
  end error   at most 1.2 times that of the same drive without that source, plus 5 cm, in the median run;
              at most twice, plus 5 cm, in 95 % of the runs

Standard output is the part of docs/dev/integrity.md that is measured, the kinds that miss a bar, and a summary. Exit
status 1 where a bar is missed or the work failed, 2 on wrong usage.
"""

import json
import pathlib
import statistics
import sys

import common

SCENARIOS = {
    "lap": ("--scenario", "lap"),
    "stop-and-go": ("--scenario", "stop-and-go"),
    "parking": ("--scenario", "parking"),
    "road": ("--scenario", "road"),
    "full-size": ("--car", "bmw_320i", "--scenario", "lap", "--speed", "15", "--duration", "60"),
}
LONGEST_SILENCE = 0.5  # s
MOST_SILENT = 0.02  # of all runs
SMALL = 0.05  # m; smaller end errors do not count
MEDIAN_RATIO = 1.2
LARGEST_RATIO = 2.0
WITHIN_LARGEST = 0.95  # of all runs

DOCUMENT = common.ROOT / "docs/dev/integrity.md"
MARKS = ("<!-- by tests/campaign/integrity.py --write: begin -->\n", "<!-- end -->\n")

ALONE = ("a speed independent of the wheels; an accelerometer shows nothing at constant speed, and at walking pace its "
         "error is as large as the speed")
CLOCK = "a second clock in the sensor"
# Kinds that no sensor contradicts, and the missing redundancy: at most eight with the camera off (False), and
# as many with it on. They are reported, but not compared with a bar.
NOT_DETECTABLE: dict[bool, dict[str, str]] = {
    False: {
        "gyro.scaled": "a yaw rate within 30 % of the gyro's; on a full-size car, steering and lateral acceleration "
                       "are not that precise",
        "gyro.ramped": "a yaw rate as precise as a gyro's bias",
        **dict.fromkeys(("wheels.frozen", "wheels.zero", "wheels.locked", "wheels.halved", "wheels.scaled",
                         "wheels.inverted"), ALONE),
    },
    True: {
        "bus.shifted": "a second clock; all frames are equally late, and at 15 m/s 50 ms are 0.75 m",
        "imu.delayed": CLOCK,
        "wheels.delayed": CLOCK,
        "camera.drifting": "a speed within 0.1 m/s, at 15 m/s",
        "wheels.scaled": "a third speed to decide between wheels and camera",
    },
}
MOST_NOT_DETECTABLE = 8


def arguments():
    parser = common.parser(__doc__, seeds=20, work=True, programs=("odom", "fault_runs"))
    parser.add_argument("--scenario", action="append", choices=SCENARIOS, help="this one; several times: these")
    parser.add_argument("--kind", action="append", metavar="NAME",
                        help="this kind of fault, or all of a part (gyro), or the drives as they are (none); "
                             "several times: these")
    parser.add_argument("--camera", choices=("on", "off", "both"), default="both",
                        help="replay with the camera, without, or both; default: both")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write every run as JSON")
    parser.add_argument("--write", action="store_true", help="write the results to docs/dev/integrity.md")
    parser.add_argument("--verbose", action="store_true", help="name every run that is silent too long")
    given = common.parse(parser)
    if given.write and (given.scenario or given.kind or given.camera != "both"):
        parser.error("--write: with all scenarios and kinds, the camera on and off")
    if max(map(len, NOT_DETECTABLE.values())) > MOST_NOT_DETECTABLE:
        sys.exit(f"integrity: {MOST_NOT_DETECTABLE} kinds at most may be declared not detectable")
    return given


def kinds(given):
    """The kinds for fault_runs: all default kinds, or the requested ones."""
    every = common.output(given.bin / "fault_runs", "--list").split()
    if not given.kind:
        return every
    chosen = []
    for one in given.kind:
        found = [kind for kind in every if kind == one or kind.startswith(one + ".")]
        # A kind outside the default set may be requested; fault_runs checks whether it exists.
        chosen += found or ([] if one == "none" else [one])
    return list(dict.fromkeys(chosen))


def measure(given, scenario, seed, folder, wanted):
    """The output lines of fault_runs for a drive."""
    lines = common.output(given.bin / "fault_runs", folder, seed, "--camera", given.camera, "--kinds",
                          ",".join(wanted) or "none")
    return [{"scenario": scenario, "seed": seed, **json.loads(line)} for line in lines.splitlines()]


def silence(one):
    """The time that the bar limits [s]: gross in silence with a camera and a fault, otherwise silent."""
    return one["silent_gross_s"] if one["camera"] and one["kind"] != "none" else one["silent_s"]


def ratio(one):
    """End error beyond 5 cm, divided by the end error without the source (at least a millimetre)."""
    return max(0.0, one["end_m"] - SMALL) / max(one["left_out_m"], 1e-3)


class Row:
    """All runs of a kind, with the camera or without."""

    def __init__(self, kind, camera, runs):
        self.kind, self.camera, self.runs = kind, camera, runs
        share = lambda chosen: sum(map(bool, chosen)) / len(runs)
        self.judged = share(silence(one) > LONGEST_SILENCE for one in runs)
        delays = [one["detected"] - one["begin"] for one in runs
                  if one["detected"] is not None and one["detected"] >= one["begin"]]
        self.detected = len(delays) / len(runs)
        self.delay = statistics.median(delays) if delays else None
        self.worst = max(silence(one) for one in runs)
        ratios = [ratio(one) for one in runs]
        self.ratio = statistics.median(ratios)
        self.within = share(value <= LARGEST_RATIO for value in ratios)
        self.excuse = NOT_DETECTABLE[camera].get(kind)
        self.missed = [] if self.excuse else list(self.bars())

    def bars(self):
        if self.judged > (0 if self.kind == "none" else MOST_SILENT):
            yield "silent"
        if self.kind != "none" and (self.ratio > MEDIAN_RATIO or self.within < WITHIN_LARGEST):
            yield "end error"

    def verdict(self):
        return (f"- {self.kind}, camera {'on' if self.camera else 'off'}: misses {', '.join(self.missed)}; silent in "
                f"{100 * self.judged:.1f} % of {len(self.runs)} runs, at most {self.worst:.2f} s; end ratio "
                f"{self.ratio:.2f}, at most {LARGEST_RATIO:g} in {100 * self.within:.0f} %")


def span(values, form):
    """The range of the values as text; empty without values."""
    shown = [form.format(value) for value in (min(values), max(values))] if values else [""]
    return " to ".join(dict.fromkeys(shown))


def documented_row(title, found, ends):
    one = found[0]
    cells = [title, span([100 * row.detected for row in found], "{:.0f}"),
             span([row.delay for row in found if row.delay is not None], "{:.2f}"),
             f"{100 * one.judged:.0f} %, {one.worst:.1f} s" if one.judged else "",
             span([statistics.median(run["worst_m"] for run in row.runs) for row in found], "{:.2f}")]
    return "| " + " | ".join(cells + ends * [span([row.ratio for row in found], "{:.2f}")]) + " |"


def documented_table(rows, ends):
    """A row for each kind that is silent in some run or not detectable, and one row for the other kinds of its part."""
    yield "| fault | reported [%] | after [s] | silent, longest | error [m] |" + ends * " end ratio |"
    yield "|---|--:|--:|--:|--:|" + ends * "--:|"
    for part in dict.fromkeys(row.kind.partition(".")[0] for row in rows):
        kinds = [row for row in rows if row.kind.startswith(f"{part}.")]
        others = [row for row in kinds if not row.judged and not row.excuse]
        alone = [row for row in kinds if row not in others] if len(others) != 1 else kinds
        for row in alone:
            yield documented_row(f"`{row.kind}`{' ¹' if row.excuse else ''}", [row], ends)
        if len(others) > 1:
            yield documented_row(f"`{part}`: {len(others)} {'others' if alone else 'kinds'}", others, ends)


def documented(rows, seeds, scenarios):
    """The part of docs/dev/integrity.md that is measured."""
    yield (f"Measured on {common.BEGUN:%F}: {seeds} simulated drives of each of {len(scenarios)} scenarios "
           f"({', '.join(scenarios)}), with one fault each.")
    for camera in (False, True):
        these = [row for row in rows if row.camera == camera and row.kind != "none"]
        if not these:
            continue
        yield f"\n## With{'' if camera else 'out'} a camera\n"
        yield from documented_table(these, ends=0 if camera else 1)  # with a camera the ratio is 0
        excuses = {}
        for row in these:
            if row.excuse:
                excuses.setdefault(row.excuse, []).append(f"`{row.kind}`")
        if excuses:
            yield "\n¹ Not always detected, because the car lacks:\n"
            yield from (f"- {', '.join(kinds)}: {excuse}." for excuse, kinds in excuses.items())
    yield ""


def write_document(measured):
    before, rest = DOCUMENT.read_text().split(MARKS[0])
    after = rest.split(MARKS[1])[1]
    DOCUMENT.write_text(before + MARKS[0] + measured + "\n" + MARKS[1] + after)


def summary(rows):
    for camera in (False, True):
        these = [row for row in rows if row.camera == camera and row.kind != "none"]
        if not these:
            continue
        runs = [one for row in these for one in row.runs]
        silent = sum(silence(one) > LONGEST_SILENCE for one in runs)
        what = "gross in silence" if camera else "silent"
        met = sum(not row.missed for row in these)
        yield (f"Camera {'on' if camera else 'off'}: {met} of {len(these)} kinds meet their bars; {silent} of "
               f"{len(runs)} runs {what} for more than {LONGEST_SILENCE} s ({100 * silent / len(runs):.1f} %), "
               f"the worst {max(map(silence, runs)):.1f} s; end error too large: "
               f"{sum('end error' in row.missed for row in these)} kinds.")


def main():
    given = arguments()
    wanted = kinds(given)
    scenarios = given.scenario or SCENARIOS
    tasks = [(scenario, SCENARIOS[scenario], seed) for scenario in scenarios for seed in range(1, given.seeds + 1)]
    drives = common.each_drive(
        given, tasks, lambda scenario, seed, folder, _: measure(given, scenario, seed, folder, wanted))
    runs = [run for drive in drives for run in drive]
    found = {}
    for one in runs:
        found.setdefault((one["camera"], one["kind"]), []).append(one)
    rows = [Row(kind, camera, ones) for (camera, kind), ones in found.items()]
    for one in runs if given.verbose else ():
        if silence(one) > (0 if one["kind"] == "none" else LONGEST_SILENCE):
            print(f"{one['scenario']}, seed {one['seed']}, camera {'on' if one['camera'] else 'off'}: {one['kind']} "
                  f"at {one['begin']:.2f} s: silent for {silence(one):.2f} s, first at "
                  f"{one['first_gross' if one['camera'] else 'first_silent']} s", file=sys.stderr)
    measured = "\n".join(documented(rows, given.seeds, scenarios))
    missed = [row.verdict() for row in rows if row.missed]
    print("\n".join([measured, *missed, *summary(rows)]), "\n")
    if given.json:
        given.json.write_text("[\n" + ",\n".join(json.dumps(one) for one in runs) + "\n]\n")
    if given.write:
        write_document(measured)
    return common.last_words(f"{len(rows) - len(missed)} kinds met, {len(missed)} missed", missed)


if __name__ == "__main__":
    common.main(main)
