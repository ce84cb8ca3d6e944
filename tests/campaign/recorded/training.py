"""tests/data/drives/training.csv: every model's figures on the training drives, which must not get worse."""

import csv
from collections.abc import Iterator

from .measure import CONFIGS, COLUMNS, Row
from .tables import JUDGED_MODEL

FILE = CONFIGS / "training.csv"

TOLERANCE = 0.03  # allowed increase of a figure of the judged model
UNCHANGED = 0.002  # allowed difference of other models: rounding, and other compilers

# The mean NEES of a pose with a consistent covariance: three degrees of freedom.
HONEST_NEES = 3.0


def write(rows: list[Row]) -> None:
    with FILE.open("w", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["drive", "model", *COLUMNS])
        for row in rows:
            figures = (f"{row.figures[column]:.4g}" if column in row.figures else "" for column in COLUMNS)
            writer.writerow([row.part.name, row.model, *figures])


def read() -> dict[tuple[str, str], dict[str, float]]:
    with FILE.open() as text:
        return {(row["drive"], row["model"]): {column: float(row[column]) for column in COLUMNS if row[column]}
                for row in csv.DictReader(text)}


def badness(column: str, value: float) -> float:
    """The figure to minimise: an error itself, for NEES its deviation in either direction."""
    if column == "camera_nees":
        return max(value / HONEST_NEES, HONEST_NEES / value)
    return value


def complaints(rows: list[Row], tolerance: float) -> Iterator[str]:
    """Figures of the judged model that are worse than in the file, and changed figures of the others."""
    known = read()
    for row in rows:
        old = known.get((row.part.name, row.model))
        if old is None:
            yield f"{row.part.name}, {row.model}: not in {FILE.name}; write it with --update"
            continue
        for column in COLUMNS:
            if (column in old) != (column in row.figures):
                yield f"{row.part.name}, {row.model}: {column} came or went; if that is right, --update"
                continue
            if column not in old:
                continue
            before, now = old[column], row.figures[column]
            if row.model == JUDGED_MODEL:
                if badness(column, now) > badness(column, before) * (1.0 + tolerance):
                    yield (f"{row.part.name}, {row.model}: {column} {now:.4g} is worse than {before:.4g} by more "
                           f"than {100 * tolerance:g} %; find out why, and if it is worth it, --update")
            elif abs(now - before) > UNCHANGED * abs(before):
                yield (f"{row.part.name}, {row.model}: {column} {now:.4g} is not the {before:.4g} that it was; "
                       "this model is to stay as it is")
