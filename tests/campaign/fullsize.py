#!/usr/bin/env python3
"""How good the filter is on full-size cars whose bodies roll and pitch: every bar, over drives of odom sim.

Three cars of published data, and one of them on stiffer anti-roll bars, drive laps, a slalom, stop-and-go, a
car park and hills, each course with N seeds of its own. They stand for 3 s first, and are replayed by dead
reckoning through the judged and the reference model, and with the camera through the judged one. Standard
output is a table in Markdown, a row a bar, and one of all courses. Exit status 1 where a bar is missed or
the work failed, 2 on wrong usage.
"""

import argparse
import datetime
import json
import os
import pathlib
import sys
import tempfile

from accuracy import drives, fullsize, runner

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def arguments():
    courses = [course.name for course in fullsize.all_courses()]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10, metavar="N",
                        help="drives of each course; default: 10")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), metavar="N",
                        help="drives in parallel; default: one per processor")
    parser.add_argument("--only", action="append", choices=fullsize.BARS, metavar="BAR",
                        help=f"this bar; several times: these. One of {', '.join(fullsize.BARS)}")
    parser.add_argument("--course", action="append", metavar="NAME",
                        help="only courses whose name begins or ends like this, such as bmw or lap-15; may be "
                             "given several times")
    parser.add_argument("--slack", type=float, default=1.0, metavar="X",
                        help="widen the limits by this factor: means of a few seeds scatter")
    parser.add_argument("--model", default="full", help="the model to evaluate; default: full")
    parser.add_argument("--reference", default="inertial", metavar="MODEL",
                        help="the reference model that it must beat; default: inertial")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write all figures as JSON")
    parser.add_argument("--work", type=pathlib.Path, metavar="DIR",
                        help="keep the simulated drives here, and reuse existing ones: "
                             "empty it when the simulator has changed")
    parser.add_argument("--odom", type=pathlib.Path, default=ROOT / "build/release/bin/odom", metavar="FILE",
                        help="the program; default: the one of the release build")
    given = parser.parse_args()
    if given.seeds < 1 or given.jobs < 1 or not given.slack >= 1:
        parser.error("--seeds, --jobs and --slack: 1 or more")
    wanted = given.course or [""]
    given.courses = [course for course in fullsize.all_courses()
                     if any(course.name.startswith(one) or course.name.endswith(one) for one in wanted)]
    if not given.courses:
        parser.error(f"--course: there are {', '.join(courses)}")
    if not os.access(given.odom, os.X_OK):
        parser.error(f"{given.odom} is missing: cmake --preset release && cmake --build --preset release")
    return given


def measure(given, course, seed, models):
    with tempfile.TemporaryDirectory(prefix="fullsize-") as scratch:
        scratch = pathlib.Path(scratch)
        folder = (given.work or scratch / "drives") / course.name / str(seed)
        try:
            return fullsize.measure(given.odom, course, seed, models, folder, scratch)
        except drives.Failed as error:
            raise drives.Failed(f"{course.name}, seed {seed}: {error}") from error


def main():
    given = arguments()
    begun = datetime.datetime.now(datetime.timezone.utc)
    models = [*dict.fromkeys((given.reference, given.model))]
    tasks = [(given, course, fullsize.seed_of(course, number), models)
             for course in given.courses for number in range(1, given.seeds + 1)]
    try:
        measured = runner.side_by_side(given.jobs, measure, tasks)
    except drives.Failed as error:
        sys.exit(f"fullsize: {error}")
    results = fullsize.Results(measured, given.model, given.reference, given.slack)
    rows = [(name, row) for name in given.only or fullsize.BARS for row in fullsize.BARS[name](results)]
    print(f"`--model {given.model}` and `{given.reference}`, {begun:%F}, {given.seeds} seeds a course; medians "
          "(smallest to largest):\n")
    print("\n".join(runner.table(rows)), "\n")
    print("\n".join(fullsize.by_course(results)), "\n")
    if given.json:
        document = {"model": given.model, "reference": given.reference, "seeds": given.seeds,
                    "rows": [{"bar": name, **vars(row)} for name, row in rows], "drives": measured}
        given.json.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    missed = sum(not row.met for _, row in rows)
    took = (datetime.datetime.now(datetime.timezone.utc) - begun).total_seconds()
    print(f"{begun:%F} fullsize: {len(rows) - missed} bars met, {missed} missed, in {took:.0f} s")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
