"""docs/dev/judged.md: a row for every look at the judged drives, and the tables of drives.py's newest look."""

import datetime
import pathlib
import statistics
import subprocess
import sys

from . import tables
from .measure import JUDGED, ROOT, Row

HEADER = "| UTC | commit | looked at | changed before; after | figures |\n|---|---|---|---|---|\n"
NEWEST = "\n## The newest look in full\n"
COLUMNS = [("heading", "heading_rms_deg", "°", 1), ("position", "position_rms_m", " m", 2)]
TRAINING = "Training drives: tests/data/drives/training.csv of that commit."
UNSAID = "?"  # what was changed: replaced by hand by whoever looked at the figures


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
    stamp, at = f"{datetime.datetime.now(datetime.timezone.utc):%F %H:%M}", commit()
    row = f"| {stamp} | {at} | {looked_at} | {UNSAID} | {figures} |"
    below = f"\n{stamp} UTC, commit {at}: {looked_at}. {TRAINING}\n\n{newest.strip()}\n" if newest else old
    whole = page.with_name(page.name + ".new")
    whole.write_text(f"{head.rstrip()}\n{row}\n" + (NEWEST + below if below else ""), encoding="utf-8")
    whole.replace(page)
    print(f"logged in {page}: write there, for {UNSAID}, what was changed before and after", file=sys.stderr)
