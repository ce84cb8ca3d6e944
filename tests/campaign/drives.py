#!/usr/bin/env python3
"""The recorded drives through every model: by dead reckoning from the reference's first pose, and with the camera.

  ODOMD_DRIVES=DIRECTORIES tests/campaign/drives.py --training [--check | --update]
  ODOMD_DRIVES=DIRECTORIES tests/campaign/drives.py --judge

Numbers are tuned on simulated cars and on the training drives, and judged on the others when a version is finished.
So --training runs the training drives alone, as often as one likes; --judge runs all drives and logs the look in
docs/dev/judged.md: it appends a row and replaces the tables of the newest look. A drive with a part for training is
cut after that part. --check compares the figures with tests/data/drives/training.csv: exit status 1 if full is worse
by more than 3 % in one of them, or another model's have changed; --update writes that file.

A drive's configuration is its own car.toml, otherwise tests/data/drives/SET.toml, where SET begins the name of its
folder. The reference's lever arm is that of [reference] there, otherwise the camera's. Output is Markdown. Exit status
1 if a check or the work failed, 2 on wrong usage.
"""

import os
import pathlib
import sys

import common
from recorded import log, measure, tables, training

DEFAULT_MODELS = ["kinematic", "paper", "inertial", "full"]
GROUPS = [("Training drives", measure.TRAINING, True), ("Judged drives", measure.JUDGED, True),
          ("Cut drives as a whole", measure.WHOLE, True), ("Apart, in no verdict", measure.APART, False)]


def arguments():
    every = sorted({part.drive for _, parts, _ in GROUPS for part in parts})
    parser = common.parser(__doc__)
    mode = parser.add_mutually_exclusive_group(required=True)
    mode.add_argument("--training", action="store_true", help="the training drives only")
    mode.add_argument("--judge", action="store_true", help="all drives, and log the look")
    then = parser.add_mutually_exclusive_group()
    then.add_argument("--check", action="store_true", help="with --training: compare with training.csv")
    then.add_argument("--update", action="store_true", help="with --training: write training.csv")
    parser.add_argument("--tolerance", type=float, default=training.TOLERANCE, metavar="X",
                        help=f"how much worse full may be with --check; default: {training.TOLERANCE:g}")
    parser.add_argument("--model", action="append", choices=measure.MODELS, metavar="MODEL",
                        help=f"this model; several times: these. Default: {', '.join(DEFAULT_MODELS)}")
    parser.add_argument("--only", action="append", choices=every, metavar="DRIVE",
                        help="this drive; several times: these")
    parser.add_argument("--log", type=pathlib.Path, default=measure.LOG, metavar="FILE",
                        help="the file that --judge logs in; default: docs/dev/judged.md")
    given = common.parse(parser)
    if (given.check or given.update) and not given.training:
        parser.error("--check and --update go with --training")
    if given.update and (given.model or given.only):
        parser.error("--update writes all models and drives: leave --model and --only out")
    return given


def main() -> int:
    given = arguments()
    groups = [(title, [part for part in parts if not given.only or part.drive in given.only], verdict)
              for title, parts, verdict in GROUPS[:1 if given.training else None]]
    parts = [part for _, some, _ in groups for part in some]
    models = given.model or DEFAULT_MODELS
    if not os.environ.get("ODOMD_DRIVES"):
        print(f"not run: {len(parts)}")
        return 0 if given.check else 2
    rows = measure.measure(given.odom, parts, models, given.jobs)
    sections = ["\n".join(tables.section(title, [row for row in rows if row.part in some], verdict))
                for title, some, verdict in groups]
    print("\n".join(filter(None, sections)))
    if given.judge:
        what = ["`drives.py --judge`", *(f"--only {drive}" for drive in given.only or []),
                *(f"--model {model}" for model in given.model or [])]
        log.add(given.log, " ".join(what), log.headline(rows),
                "" if given.only or given.model else "\n".join(filter(None, sections[1:])))
    if given.update:
        training.write(rows)
    worse = list(training.complaints(rows, given.tolerance)) if given.check else []
    for line in worse:
        print(f"drives: {line}", file=sys.stderr)
    return 1 if worse else 0


if __name__ == "__main__":
    common.main(main)
