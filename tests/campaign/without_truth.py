#!/usr/bin/env python3
"""Drives judged without their truth, compared with the judgement by it: position rms and order of the models.

  tests/campaign/without_truth.py                               simulated drives
  ODOMD_DRIVES=DIRECTORY tests/campaign/without_truth.py --training    recorded training drives
  ODOMD_DRIVES=DIRECTORY tests/campaign/without_truth.py --judged      the others: log the look in docs/judged.md

Each drive is evaluated twice, by dead reckoning and with the camera: as it is, and in a folder without truth.csv.
Two models whose true rms differ by less than 5 % may change places. Exit status 1 where an rms is off by more than
25 % or the order differs.
"""

import itertools
import json
import pathlib
import sys
import tempfile

from recorded import measure

MODELS = ["kinematic", "paper", "inertial", "full"]
MOST_OFF = 0.25
EQUAL = 0.05
COURSES = {"laps": ["--scenario", "lap", "--laps", "3"], "slalom": ["--scenario", "slalom", "--duration", "40"]}


def rms(odom: pathlib.Path, folder: pathlib.Path, *options: str) -> dict[str, float]:
    models = [word for model in MODELS for word in ("--model", model)]
    text = measure.run(odom, "evaluate", "--drive", folder, *models, *options, "--json")
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


def compare(odom: pathlib.Path, folder: pathlib.Path, name: str, options: tuple[str, ...], arm: str) -> bool:
    good = True
    with tempfile.TemporaryDirectory() as work:
        blind = without_truth(folder, pathlib.Path(work))
        for how in ("dead reckoning", "camera"):
            given = (*options, *(["--dead-reckoning"] if how != "camera" else []))
            true = rms(odom, folder, *given, *([f"--lever-arm={arm}"] if arm else []))
            found = rms(odom, blind, *given)
            order = same_order(true, found)
            good = good and order
            for model in MODELS:
                ratio = found[model] / true[model]
                good = good and abs(ratio - 1) <= MOST_OFF
                print(f"| {name} | {how} | {model} | {true[model]:.4f} | {found[model]:.4f} | {ratio:.2f} | "
                      f"{'yes' if order else 'no'} |", flush=True)
    return good


def main() -> int:
    chosen = measure.choose(__doc__ or "", seeds=3, judged=measure.JUDGED + measure.APART)
    print("| drive | | model | true rms [m] | without truth [m] | ratio | same order |\n|---|---|---|--:|--:|--:|---|")
    good = True
    for part in chosen.parts:
        folder = chosen.drives / part.drive
        if part.drive in measure.VELOCITIES_ONLY or not (folder / "camera.csv").exists():
            continue
        config = measure.config_of(part.drive)
        good &= compare(chosen.odom, folder, part.name, ("--config", str(config), *part.options),
                        measure.lever_arm(config))
    if chosen.parts:
        return 0 if good else 1
    with tempfile.TemporaryDirectory() as work:
        for (course, options), seed in itertools.product(COURSES.items(), range(1, chosen.seeds + 1)):
            folder = pathlib.Path(work) / f"{course}_{seed}"
            measure.run(chosen.odom, "sim", *options, "--seed", seed, "--out", folder)
            good &= compare(chosen.odom, folder, folder.name, (), "")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
