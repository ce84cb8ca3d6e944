#!/usr/bin/env python3
"""How good the filter is on a plant that is not its own model: every bar, over many drives of odom sim.

Each course (scenario, speed, errors, camera) is driven with the seeds 1 to N, replayed through the models
and evaluated against the truth. Standard output is a table in Markdown, a row a bar; a folder gets it with
charts. Where ODOMD_DRIVES names folders of recorded drives, and no bar is asked for by name, the tables of those
for training follow. Exit status 1 where a bar is missed or the work failed, 2 on wrong usage.
"""

import argparse
import datetime
import json
import os
import pathlib
import sys
import tempfile

from accuracy import bars, charts, courses, drives, runner

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20, metavar="N",
                        help="drives of each course; default: 20")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), metavar="N",
                        help="drives in parallel; default: one per processor")
    parser.add_argument("--only", action="append", choices=bars.BARS, metavar="BAR",
                        help=f"this bar; several times: these. One of {', '.join(bars.BARS)}")
    parser.add_argument("--speed", action="append", type=float, choices=courses.SPEEDS, metavar="V",
                        help="laps at this speed only; may be given several times. One of "
                             f"{', '.join(f'{speed:g}' for speed in courses.SPEEDS)} m/s")
    parser.add_argument("--slack", type=float, default=1.0, metavar="X",
                        help="widen the limits by this factor: medians of a few seeds scatter")
    parser.add_argument("--model", default="full", help="the model to evaluate; default: full")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/accuracy", metavar="DIR",
                        help="folder for the table, charts and figures; default: build/accuracy")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write all figures as JSON")
    parser.add_argument("--work", type=pathlib.Path, metavar="DIR",
                        help="keep the simulated drives here, and reuse existing ones: "
                             "empty it when the simulator has changed")
    parser.add_argument("--odom", type=pathlib.Path, default=ROOT / "build/release/bin/odom", metavar="FILE",
                        help="the program; default: the one of the release build")
    given = parser.parse_args()
    if given.seeds < 1 or given.jobs < 1 or not given.slack >= 1:
        parser.error("--seeds, --jobs and --slack: 1 or more")
    if not os.access(given.odom, os.X_OK):
        parser.error(f"{given.odom} is missing: cmake --preset release && cmake --build --preset release")
    return given


def measure(given, course, seed, models):
    with tempfile.TemporaryDirectory(prefix="accuracy-") as scratch:
        folder = (given.work or pathlib.Path(scratch) / "drives") / course.name / str(seed)
        picture = given.out / f"{course.name}.svg" if seed == 1 else None
        try:
            return drives.measure(given.odom, course, seed, models, folder, scratch, picture)
        except drives.Failed as error:
            raise drives.Failed(f"{course.name}, seed {seed}: {error}") from error


def measure_all(given, wanted, models):
    """All drives of all courses, side by side, in the order of courses and seeds."""
    tasks = [(given, course, seed, models) for course in wanted for seed in range(1, given.seeds + 1)]
    return runner.side_by_side(given.jobs, measure, tasks)


def recorded_drives(odom, models):
    """The tables of the training drives; nothing if there are none."""
    if not os.environ.get("ODOMD_DRIVES"):
        return ""
    done = drives.run(ROOT / "tests/campaign/drives.py", "--training", "--odom", odom.resolve(),
                      *(f"--model={model}" for model in models))
    return f"\n{done.stdout}"


def main():
    given = arguments()
    wanted = given.only or list(bars.BARS)
    speeds = given.speed or courses.SPEEDS
    compared = ["kinematic", "paper"]
    models = [*(model for model in compared if model != given.model), given.model]
    given.out.mkdir(parents=True, exist_ok=True)
    begun = datetime.datetime.now(datetime.timezone.utc)
    try:
        found = measure_all(given, bars.courses_of(wanted, speeds), models)
        recorded = "" if given.only else recorded_drives(given.odom, models)
    except drives.Failed as error:
        sys.exit(f"accuracy: {error}")
    results = bars.Results(found, given.model, compared, speeds, given.slack)
    rows = [(name, row) for name in bars.BARS if name in wanted for row in bars.BARS[name][0](results)]

    missed = sum(not row.met for _, row in rows)
    took = (datetime.datetime.now(datetime.timezone.utc) - begun).total_seconds()
    heading = (f"`--model {given.model}`, {begun:%F}, {given.seeds} seeds a course; medians (smallest to "
               "largest):")
    text = "\n".join([heading, "", *runner.table(rows), ""]) + recorded
    (given.out / "table.md").write_text(text)
    charts.write(results, given.out)
    print(text)
    if given.json:
        document = {"model": given.model, "seeds": given.seeds,
                    "rows": [{"bar": name, **vars(row)} for name, row in rows],
                    "drives": [drive for course in results.by_course.values() for drive in course]}
        given.json.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    print(f"{begun:%F} accuracy: {len(rows) - missed} bars met, {missed} missed, in {took:.0f} s")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
