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
from collections.abc import Iterator
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


def compare(odom: pathlib.Path, folder: pathlib.Path, name: str, options: tuple[str, ...]) -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as work:
        blind = without_truth(folder, pathlib.Path(work))
        for how in ("dead reckoning", "camera"):
            given = (*options, *(["--dead-reckoning"] if how != "camera" else []))
            true = rms(odom, folder, *given)
            found = rms(odom, blind, *given)
            order = same_order(true, found)
            for model in MODELS:
                ratio = found[model] / true[model]
                print(f"| {name} | {how} | {model} | {true[model]:.4f} | {found[model]:.4f} | {ratio:.2f} | "
                      f"{'yes' if order else 'no'} |", flush=True)
                yield Row(name, how, model, ratio, order)


def headline(rows: list[Row]) -> str:
    ratios = {how: [row.ratio for row in rows if row.how == how] for how in dict.fromkeys(row.how for row in rows)}
    ranges = [f"{how} {min(some):.2f} to {max(some):.2f}" for how, some in ratios.items()]
    off = [f"{row.drive} {row.how} {row.model} {row.ratio:.2f}" for row in rows if row.off]
    other = dict.fromkeys(f"{row.drive} {row.how}" for row in rows if not row.same_order)
    return (f"position rms without truth / true: {', '.join(ranges)}; off by more than {100 * MOST_OFF:.0f} %: "
            f"{', '.join(off) or 'none'}; another order: {', '.join(other) or 'none'}")


def status(rows: list[Row]) -> int:
    return 1 if any(row.off or not row.same_order for row in rows) else 0


def main() -> int:
    chosen = measure.choose(__doc__ or "", seeds=3, judged=measure.JUDGED + measure.APART)
    print("| drive | | model | true rms [m] | without truth [m] | ratio | same order |\n|---|---|---|--:|--:|--:|---|")
    rows: list[Row] = []
    try:
        for part in chosen.parts:
            folder = measure.folder_of(part.drive)
            if part.drive in measure.VELOCITIES_ONLY or not (folder / "camera.csv").exists():
                continue
            config = measure.config_of(folder)
            rows += compare(chosen.odom, folder, part.name, ("--config", str(config), *part.options))
    finally:
        if chosen.log and rows:  # even if it was interrupted
            log.add(chosen.log, f"`without_truth.py --judged`, {', '.join(dict.fromkeys(row.drive for row in rows))}",
                    headline(rows))
    if chosen.parts:
        return status(rows)
    with tempfile.TemporaryDirectory() as work:
        for (course, options), seed in itertools.product(COURSES.items(), range(1, chosen.seeds + 1)):
            folder = pathlib.Path(work) / f"{course}_{seed}"
            common.output(chosen.odom, "sim", *options, "--seed", seed, "--out", folder)
            rows += compare(chosen.odom, folder, folder.name, ())
    return status(rows)


if __name__ == "__main__":
    common.main(main)
