#!/usr/bin/env python3
"""How good the filter is on a plant that is not its own model: every bar, over many drives of odom sim.

Each course is driven with N seeds, replayed through the models and evaluated against the truth. The small car
drives the courses at several speeds, with and without its camera (scenario, speed, errors); three full-size
cars of published data, whose bodies roll and pitch, and one of them on stiffer anti-roll bars drive laps, a
slalom, stop-and-go, a car park and hills. Standard output is a table in Markdown, a row per bar. Exit
status 1 if a bar is missed or the work failed, 2 on wrong usage.
"""

import common
from accuracy import bars, courses, drives, fullsize


def arguments():
    every = [*dict.fromkeys((*bars.BARS, *fullsize.BARS))]
    parser = common.parser(__doc__, seeds=20, work=True)
    parser.add_argument("--only", action="append", choices=every, metavar="BAR",
                        help=f"this bar; several times: these. One of {', '.join(every)}")
    parser.add_argument("--slack", type=float, default=1.0, metavar="X",
                        help="widen the limits by this factor: figures of a few seeds scatter")
    parser.add_argument("--model", default="full", help="the model to evaluate; default: full")
    parser.add_argument("--full-size", dest="campaign", action="store_const", const=fullsize, default=bars,
                        help="the full-size cars in place of the small one")
    parser.add_argument("--speed", action="append", type=float, choices=courses.SPEEDS, metavar="V",
                        help="laps of the small car at this speed only; may be given several times. One of "
                             f"{', '.join(f'{speed:g}' for speed in courses.SPEEDS)} m/s")
    given = common.parse(parser)
    given.speed = given.speed or courses.SPEEDS
    if unknown := set(given.only or ()) - set(given.campaign.BARS):
        parser.error(f"--only {unknown.pop()}: there are {', '.join(given.campaign.BARS)}")
    return given


def main():
    given = arguments()
    campaign, wanted = given.campaign, given.only or list(given.campaign.BARS)
    models = [*(one for one in campaign.COMPARED if one != given.model), given.model]
    read = tuple(begin for name in wanted for begin in campaign.BARS[name][1])
    courses_read = {course.name: course for course in campaign.all_courses(given.speed) if course.name.startswith(read)}
    tasks = [(course.name, course.options, course.seeds_after + number) for course in courses_read.values()
             for number in range(1, given.seeds + 1)]
    measured = common.each_drive(given, tasks, lambda name, seed, folder, scratch: {
        "course": name, "seed": seed, **drives.measure(given.odom, courses_read[name], models, folder, scratch)})
    results = campaign.Results(measured, given)
    rows = [(name, row) for name in wanted for row in campaign.BARS[name][0](results)]
    print(f"`--model {given.model}`, {common.BEGUN:%F}, {given.seeds} seeds a course; medians (smallest to largest):\n")
    print("\n".join(common.table(rows)), "\n")
    if campaign is fullsize:
        print("\n".join(fullsize.further(results)))
    return common.finish(rows)


if __name__ == "__main__":
    common.main(main)
