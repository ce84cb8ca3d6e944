#!/usr/bin/env python3
"""How good the filter is on a plant that is not its own model: every bar, over many drives of odom sim.

Each course (scenario, speed, errors, camera) is driven with the seeds 1 to N, replayed through the models
and evaluated against the truth. Standard output is a table in Markdown, a row per bar; --out's folder gets it
too, with charts. If ODOMD_DRIVES names folders of recorded drives, and no bar is asked for by name, the tables
of the training drives follow. Exit status 1 if a bar is missed or the work failed, 2 on wrong usage.
"""

import os
import pathlib

import common
from accuracy import bars, charts, courses, drives


def arguments():
    parser = common.parser(__doc__, seeds=20)
    common.add_bars(parser, bars.BARS)
    parser.add_argument("--speed", action="append", type=float, choices=courses.SPEEDS, metavar="V",
                        help="laps at this speed only; may be given several times. One of "
                             f"{', '.join(f'{speed:g}' for speed in courses.SPEEDS)} m/s")
    parser.add_argument("--out", type=pathlib.Path, default=common.ROOT / "build/accuracy", metavar="DIR",
                        help="folder for the table, charts and figures; default: build/accuracy")
    return common.parse(parser)


def recorded_drives(odom, models):
    """The tables of the training drives; nothing if there are none."""
    if not os.environ.get("ODOMD_DRIVES"):
        return ""
    return "\n" + common.output(common.ROOT / "tests/campaign/drives.py", "--training", "--odom", odom.resolve(),
                                *(f"--model={model}" for model in models))


def main():
    given = arguments()
    wanted = given.only or list(bars.BARS)
    speeds = given.speed or courses.SPEEDS
    compared = ["kinematic", "paper"]
    models = [*(model for model in compared if model != given.model), given.model]
    given.out.mkdir(parents=True, exist_ok=True)
    begun = common.now()
    found = common.each_drive(
        given, lambda course, seed, folder, scratch: drives.measure(
            given.odom, course, seed, models, folder, scratch, given.out / f"{course.name}.svg" if seed == 1 else None),
        [(course, seed) for course in bars.courses_of(wanted, speeds) for seed in range(1, given.seeds + 1)])
    recorded = "" if given.only else recorded_drives(given.odom, models)
    results = bars.Results(found, given.model, compared, speeds, given.slack)
    rows = [(name, row) for name in bars.BARS if name in wanted for row in bars.BARS[name][0](results)]

    heading = (f"`--model {given.model}`, {begun:%F}, {given.seeds} seeds a course; medians (smallest to "
               "largest):")
    text = "\n".join([heading, "", *common.table(rows), ""]) + recorded
    (given.out / "table.md").write_text(text)
    charts.write(results, given.out)
    print(text)
    return common.finish("accuracy", begun, rows, given.json,
                         {"model": given.model, "seeds": given.seeds,
                          "drives": [drive for course in results.by_course.values() for drive in course]})


if __name__ == "__main__":
    common.main(main)
