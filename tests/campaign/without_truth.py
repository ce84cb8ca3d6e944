#!/usr/bin/env python3
"""Drives judged without their truth, compared with the judgement by it: position rms and order of the models.

  tests/campaign/without_truth.py                                      simulated drives
  ODOMD_DRIVES=DIRECTORIES tests/campaign/without_truth.py --training  recorded training drives
  ODOMD_DRIVES=DIRECTORIES tests/campaign/without_truth.py --judged    the others; logs the look in docs/dev/judged.md

Each drive is evaluated twice, by dead reckoning and with the camera: as it is, and in a folder without truth.csv.
Two models whose true rms differ by less than 5 % may change places. Exit status 1 where an rms is off by more than
25 % or the order differs.
"""

import itertools
import json
import pathlib
import tempfile
from typing import NamedTuple

import common
from recorded import log, measure

MODELS = ["kinematic", "paper", "inertial", "full"]
MOST_OFF = 0.25
EQUAL = 0.05
COURSES = {"laps": ["--scenario", "lap", "--laps", "3"], "slalom": ["--scenario", "slalom", "--duration", "40"]}


class Row(NamedTuple):
    drive: str
    how: str
    model: str
    ratio: float  # rms without truth / true rms
    same_order: bool

    @property
    def off(self) -> bool:
        return not abs(self.ratio - 1) <= MOST_OFF  # also for NaN


class Found(NamedTuple):
    rows: list[Row]

    def drives(self) -> list[str]:
        return [row.drive for row in self.rows]

    def good(self) -> bool:
        return not any(row.off or not row.same_order for row in self.rows)

    def headline(self) -> str:
        ratios: dict[str, list[float]] = {}
        for row in self.rows:
            ratios.setdefault(row.how, []).append(row.ratio)
        ranges = [f"{how} {min(some):.2f} to {max(some):.2f}" for how, some in ratios.items()]
        off = [f"{row.drive} {row.how} {row.model} {row.ratio:.2f}" for row in self.rows if row.off]
        other = dict.fromkeys(f"{row.drive} {row.how}" for row in self.rows if not row.same_order)
        return (f"position rms without truth / true: {', '.join(ranges)}; off by more than {100 * MOST_OFF:.0f} %: "
                f"{', '.join(off) or 'none'}; another order: {', '.join(other) or 'none'}")


def rms(odom: pathlib.Path, folder: pathlib.Path, *options: str) -> dict[str, float]:
    models = [word for model in MODELS for word in ("--model", model)]
    text = common.output(odom, "evaluate", "--drive", folder, *models, *options, "--json")
    return {one["pose"]: one["position"]["rms"] for one in json.loads(text)["drives"][0]["estimates"]}


def same_order(true: dict[str, float], found: dict[str, float]) -> bool:
    return all((true[a] < true[b]) == (found[a] < found[b])
               for a, b in itertools.combinations(MODELS, 2)
               if abs(true[a] - true[b]) > EQUAL * max(true[a], true[b]))


def without_truth(folder: pathlib.Path, work: pathlib.Path) -> pathlib.Path:
    copy = work / "without" / folder.name
    copy.mkdir(parents=True)
    for file in folder.iterdir():
        if file.name != "truth.csv":
            (copy / file.name).symlink_to(file.resolve())
    return copy


def compare(odom: pathlib.Path, folder: pathlib.Path, part: measure.Part, recorded: bool, found: Found) -> None:
    if recorded and (part.drive in measure.VELOCITIES_ONLY or not (folder / "camera.csv").exists()):
        return
    options = ("--config", str(measure.config_of(folder)), *part.options) if recorded else ()
    with tempfile.TemporaryDirectory() as work:
        blind = without_truth(folder, pathlib.Path(work))
        for how, more in (("dead reckoning", ["--dead-reckoning"]), ("camera", [])):
            true, seen = rms(odom, folder, *options, *more), rms(odom, blind, *options, *more)
            order = same_order(true, seen)
            for model in MODELS:
                ratio = seen[model] / true[model]
                print(f"| {part.name} | {how} | {model} | {true[model]:.4f} | {seen[model]:.4f} | {ratio:.2f} | "
                      f"{'yes' if order else 'no'} |", flush=True)
                found.rows.append(Row(part.name, how, model, ratio, order))


def main() -> int:
    found = Found([])
    return log.look(
        __doc__ or "",
        "| drive | | model | true rms [m] | without truth [m] | ratio | same order |\n|---|---|---|--:|--:|--:|---|",
        3, measure.JUDGED + measure.APART, COURSES, found, lambda *drive: compare(*drive, found))


if __name__ == "__main__":
    common.main(main)
