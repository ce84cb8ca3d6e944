#!/usr/bin/env python3
"""How good the filter is on full-size cars whose bodies roll and pitch: every bar, over drives of odom sim.

Three cars of published data, and one of them on stiffer anti-roll bars, drive laps, a slalom, stop-and-go, a
car park and hills, each course with N seeds of its own. They stand for 3 s first, and are replayed by dead
reckoning through the judged and the reference model, and with the camera through the judged one. Standard
output is a table in Markdown, a row a bar, and one of all courses. Exit status 1 where a bar is missed or
the work failed, 2 on wrong usage.
"""

import datetime
import pathlib
import sys
import tempfile

import common
from accuracy import fullsize


def arguments():
    parser = common.parser(__doc__, seeds=10)
    common.add_bars(parser, fullsize.BARS)
    parser.add_argument("--course", action="append", metavar="NAME",
                        help="only courses whose name begins or ends like this, such as bmw or lap-15; may be "
                             "given several times")
    parser.add_argument("--reference", default="inertial", metavar="MODEL",
                        help="the reference model that it must beat; default: inertial")
    given = common.parse(parser)
    wanted = given.course or [""]
    given.courses = [course for course in fullsize.all_courses()
                     if any(course.name.startswith(one) or course.name.endswith(one) for one in wanted)]
    if not given.courses:
        parser.error(f"--course: there are {', '.join(course.name for course in fullsize.all_courses())}")
    return given


def measure(given, course, seed, models):
    with tempfile.TemporaryDirectory(prefix="fullsize-") as scratch:
        scratch = pathlib.Path(scratch)
        folder = (given.work or scratch / "drives") / course.name / str(seed)
        try:
            return fullsize.measure(given.odom, course, seed, models, folder, scratch)
        except common.Failed as error:
            raise common.Failed(f"{course.name}, seed {seed}: {error}") from error


def main():
    given = arguments()
    begun = datetime.datetime.now(datetime.timezone.utc)
    models = [*dict.fromkeys((given.reference, given.model))]
    tasks = [(given, course, fullsize.seed_of(course, number), models)
             for course in given.courses for number in range(1, given.seeds + 1)]
    try:
        measured = common.side_by_side(given.jobs, measure, tasks)
    except common.Failed as error:
        sys.exit(f"fullsize: {error}")
    results = fullsize.Results(measured, given.model, given.reference, given.slack)
    rows = [(name, row) for name in given.only or fullsize.BARS for row in fullsize.BARS[name](results)]
    print(f"`--model {given.model}` and `{given.reference}`, {begun:%F}, {given.seeds} seeds a course; medians "
          "(smallest to largest):\n")
    print("\n".join(common.table(rows)), "\n")
    print("\n".join(fullsize.by_course(results)), "\n")
    common.finish("fullsize", begun, rows, given.json,
                  {"model": given.model, "reference": given.reference, "seeds": given.seeds, "drives": measured})


if __name__ == "__main__":
    main()
