#!/usr/bin/env python3
"""How good the filter is on full-size cars whose bodies roll and pitch: every bar, over drives of odom sim.

Three cars of published data, and one of them on stiffer anti-roll bars, drive laps, a slalom, stop-and-go, a
car park and hills, each course with N seeds of its own. They stand for 3 s first, and are replayed by dead
reckoning through the judged and the reference model, and with the camera through the judged one. Standard
output is a table in Markdown with a row per bar, and one of all courses. Exit status 1 if a bar is missed or
the work failed, 2 on wrong usage.
"""

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


def main():
    given = arguments()
    begun = common.now()
    models = [*dict.fromkeys((given.reference, given.model))]
    measured = common.each_drive(
        given, lambda course, seed, folder, scratch: fullsize.measure(given.odom, course, seed, models, folder, scratch),
        [(course, fullsize.seed_of(course, number))
         for course in given.courses for number in range(1, given.seeds + 1)])
    results = fullsize.Results(measured, given.model, given.reference, slack=given.slack)
    rows = [(name, row) for name in given.only or fullsize.BARS for row in fullsize.BARS[name](results)]
    print(f"`--model {given.model}` and `{given.reference}`, {begun:%F}, {given.seeds} seeds a course; medians "
          "(smallest to largest):\n")
    print("\n".join(common.table(rows)), "\n")
    print("\n".join(fullsize.by_course(results)), "\n")
    return common.finish("fullsize", begun, rows, given.json, {
        "model": given.model, "reference": given.reference, "seeds": given.seeds, "drives": measured})


if __name__ == "__main__":
    common.main(main)
