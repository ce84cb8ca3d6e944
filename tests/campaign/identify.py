#!/usr/bin/env python3
"""How accurate odom identify and its stated uncertainties are, on simulated cars that differ from its model.

Each method measures one car per seed; its true values are known. They must lie within the stated 2 sigma for
35 of 40 seeds or more (or in that proportion of another number), and 2 sigma must be small enough where there
is a bar. Standard output is a table in Markdown. Exit status 1 if a bar is missed or the work
failed, 2 on wrong usage.
"""

import pathlib
import sys
import time

import common
from identify.methods import METHODS, ONE_SEED, rows_of


def arguments():
    parser = common.parser(__doc__, seeds=40, what="cars")
    parser.add_argument("--only", action="append", choices=METHODS, metavar="METHOD",
                        help=f"this method; several times: these. One of {', '.join(METHODS)}")
    parser.add_argument("--first", type=int, default=1, metavar="N", help="the first seed; default: 1")
    parser.add_argument("--work", type=pathlib.Path, metavar="DIR",
                        help="keep the experiments here; default: they are removed")
    given = common.parse(parser)
    if given.first < 0:
        parser.error("--first: 0 or more")
    return given


def line(row):
    bar = f"{row.bar:g} {row.unit}" if row.bar is not None else ""
    left_out = f", {row.undetermined} not determined" if row.undetermined else ""
    return (f"| {row.what} | {row.inside} of {row.of}{left_out} | {row.stated:.2g} {row.unit} | {bar} "
            f"| {row.error:.2g} {row.unit} | {'met' if row.met else '**missed**'} |")


def main():
    given = arguments()
    seeds = range(given.first, given.first + given.seeds)
    met = True
    print(f"{common.BEGUN:%F}, seeds {seeds[0]} to {seeds[-1]}\n")
    print("| value | true value within 2 sigma | largest 2 sigma | its bar | rms error | |")
    print("|---|--:|--:|--:|--:|---|")
    for method in given.only or METHODS:
        begun = time.monotonic()
        with common.scratch() as scratch:
            work = (given.work or scratch) / method
            work.mkdir(parents=True, exist_ok=True)
            try:
                for experiment in METHODS[method]:
                    for row in rows_of(experiment, seeds[:1] if method in ONE_SEED else seeds, work, given):
                        met = met and row.met
                        print(line(row), flush=True)
            except common.Failed as error:
                met = False
                print(f"identify.py: {method}: {error}", file=sys.stderr)
        print(f"identify.py: {method}: {time.monotonic() - begun:.0f} s", file=sys.stderr)
    return 0 if met else 1


if __name__ == "__main__":
    common.main(main)
