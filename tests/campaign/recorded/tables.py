"""Tables in Markdown: errors of every model on every drive, and full against the model to beat."""

from collections.abc import Iterator

from common import geometric_mean

from .measure import CELLS, COLUMNS, Part, Row

JUDGED_MODEL = "full"
TO_BEAT = "inertial"

GOOD_RATIO = 1.05  # limit for three quarters of the cells
BAD_RATIO = 1.3  # a worse cell must be explained by an experiment


def table(rows: list[Row]) -> Iterator[str]:
    columns = {name: shown for name, shown in COLUMNS.items() if any(name in row.figures for row in rows)}
    yield "| drive | model | " + " | ".join(header for header, _ in columns.values()) + " | remark |"
    yield "|---|---|" + "--:|" * len(columns) + "---|"
    for row in rows:
        cells = [f"{row.figures[name]:.{digits}f}" if name in row.figures else ""
                 for name, (_, digits) in columns.items()]
        yield f"| {row.part.name} | {row.model} | " + " | ".join(cells) + f" | {row.remark} |"


def ratios(rows: list[Row]) -> dict[Part, dict[str, float]]:
    """full / inertial, by drive and cell; nothing if one of them was not measured."""
    of = {(row.part, row.model): row.figures for row in rows}
    found = {}
    for part in dict.fromkeys(row.part for row in rows):
        mine, theirs = of.get((part, JUDGED_MODEL)), of.get((part, TO_BEAT))
        if mine and theirs:
            found[part] = {cell: mine[cell] / theirs[cell] for cell in CELLS if cell in mine}
    return found


def summary(rows: list[Row]) -> Iterator[str]:
    """A summary of the ratios; nothing if there are none."""
    every = [(part, cell, ratio) for part, cells in ratios(rows).items() for cell, ratio in cells.items()]
    if not every:
        return
    good = sum(ratio <= GOOD_RATIO for _, _, ratio in every)
    yield f"at most {GOOD_RATIO}: {good} of {len(every)} cells, {100 * good / len(every):.0f} %"
    bad = [f"{part.name} {CELLS[cell]} {ratio:.2f}" for part, cell, ratio in every if ratio > BAD_RATIO]
    yield f"above {BAD_RATIO}: {', '.join(bad) or 'none'}"


def comparison(rows: list[Row]) -> Iterator[str]:
    found = ratios(rows)
    yield from (f"{JUDGED_MODEL} / {TO_BEAT}:", "", "| drive | heading rms | position rms | 35 ms |", "|---|--:|--:|--:|")
    for part, cells in found.items():
        yield f"| {part.name} | " + " | ".join(f"{cells[cell]:.2f}" if cell in cells else "" for cell in CELLS) + " |"
    means = {cell: [cells[cell] for cells in found.values() if cell in cells] for cell in CELLS}
    yield "| geometric mean | " + " | ".join(
        f"{geometric_mean(values):.2f}" if values else "" for values in means.values()) + " |"
    yield from ("", *(f"- {line}" for line in summary(rows)))


def section(title: str, rows: list[Row], verdict: bool) -> Iterator[str]:
    """The errors and the comparison of a group of drives."""
    if rows:
        yield from (f"### {title}", "", "By dead reckoning, unless with the camera:", "", *table(rows), "")
        if verdict and ratios(rows):
            yield from (*comparison(rows), "")
