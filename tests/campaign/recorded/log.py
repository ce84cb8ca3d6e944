"""docs/dev/judged.md: a row for every look at the judged drives, and the tables of drives.py's newest look."""

import itertools
import os
import pathlib
import statistics
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import common

from . import tables
from .measure import JUDGED, LOG, ROOT, TRAINING, Part, Row, folder_of

HEADER = "| UTC | commit | looked at | changed before; after | figures |\n|---|---|---|---|---|\n"
NEWEST = "\n## The newest look in full\n"
COLUMNS = [("heading", "heading_rms_deg", "°", 1), ("position", "position_rms_m", " m", 2)]
OF_TRAINING = "Training drives: tests/data/drives/training.csv of that commit."
UNSAID = "?"  # what was changed; to be replaced by hand after a look at the figures


def commit() -> str:
    def git(*words: str) -> str:
        return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True,
                              check=False).stdout.strip()
    changed = git("status", "--porcelain", "--untracked-files=no")
    return (git("rev-parse", "--short=12", "HEAD") or "unknown") + (", with changes" if changed else "")


def headline(rows: list[Row]) -> str:
    """Median and worst error of dead reckoning on the judged drives, and the summary of the ratios."""
    rows = [row for row in rows if row.part in JUDGED]
    found = []
    for name, column, unit, digits in COLUMNS:
        errors = [(row.figures[column], row.part.name) for row in rows
                  if row.model == tables.JUDGED_MODEL and column in row.figures]
        if errors:
            worst, drive = max(errors)
            median = statistics.median(error for error, _ in errors)
            found.append(f"{name} {median:.{digits}f}{unit} median, {worst:.{digits}f}{unit} worst ({drive})")
    return "; ".join([*found, *tables.summary(rows)]) or "none of judged drives"


def add(page: pathlib.Path, looked_at: str, figures: str, newest: str = "") -> None:
    """Append a look's row; if `newest` is given, replace the tables with it."""
    text = page.read_text(encoding="utf-8") if page.exists() else HEADER
    head, _, old = text.partition(NEWEST)
    stamp, at = f"{common.BEGUN:%F %H:%M}", commit()
    row = f"| {stamp} | {at} | {looked_at} | {UNSAID} | {figures} |"
    below = f"\n{stamp} UTC, commit {at}: {looked_at}. {OF_TRAINING}\n\n{newest.strip()}\n" if newest else old
    whole = page.with_name(page.name + ".new")
    whole.write_text(f"{head.rstrip()}\n{row}\n" + (NEWEST + below if below else ""), encoding="utf-8")
    whole.replace(page)
    print(f"logged in {page}: write there, for {UNSAID}, what was changed before and after", file=sys.stderr)


Line = dict[str, Any]  # what a campaign found: drive, text to print, whether it is bad, and what the headline needs


def look(doc: str, header: str, seeds: int, judged: list[Part], courses: dict[str, list[str]],
         compare: Callable[[pathlib.Path, pathlib.Path, Part, bool], Iterable[Line]],
         headline_of: Callable[[list[Line]], str]) -> int:
    """A campaign with this docstring: compares the recorded drives that its command line asks for, and logs the look at
    those that judge; without any, simulated drives. `compare(odom, folder, part, recorded)` finds lines. Returns the
    exit status."""
    parser = common.parser(doc, seeds, "simulated drives per course", jobs=False)
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--training", action="store_true", help="the recorded training drives")
    which.add_argument("--judged", action="store_true", help="the recorded drives that judge; logged")
    parser.add_argument("--log", type=pathlib.Path, default=LOG, metavar="FILE",
                        help="the file that --judged logs in; default: docs/dev/judged.md")
    given = common.parse(parser)
    parts = TRAINING if given.training else judged if given.judged else []
    if parts and not os.environ.get("ODOMD_DRIVES"):
        sys.exit(f"{parser.prog}: set ODOMD_DRIVES to the folders of recorded drives")

    def drives(work: pathlib.Path) -> Iterator[tuple[pathlib.Path, Part]]:
        yield from ((folder_of(part.drive), part) for part in parts)
        for course, seed in itertools.product({} if parts else courses, range(1, given.seeds + 1)):
            folder = work / f"{course}_{seed}"
            common.simulate(given.odom, courses[course], seed, folder)
            yield folder, Part(folder.name)

    found = []
    print(header)
    try:
        with common.scratch() as work:
            for folder, part in drives(work):
                for line in compare(given.odom, folder, part, bool(parts)):
                    found.append(line)
                    print(line["text"], flush=True)
    finally:
        if given.judged and found:  # even if it was interrupted
            names = ", ".join(dict.fromkeys(line["drive"] for line in found))
            add(given.log, f"`{pathlib.Path(sys.argv[0]).stem}.py --judged`, {names}", headline_of(found))
    return 1 if any(line["bad"] for line in found) else 0
