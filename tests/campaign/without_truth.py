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
from collections.abc import Iterator

import common
from recorded import log, measure

MODELS = ["kinematic", "paper", "inertial", "full"]
MOST_OFF = 0.25
EQUAL = 0.05
COURSES = {"laps": ["--scenario", "lap", "--laps", "3"], "slalom": ["--scenario", "slalom", "--duration", "40"]}


def headline(lines: list[log.Line]) -> str:
    ratios: dict[str, list[float]] = {}
    for line in lines:
        ratios.setdefault(line["how"], []).append(line["ratio"])
    ranges = [f"{how} {min(some):.2f} to {max(some):.2f}" for how, some in ratios.items()]
    off = [f"{line['drive']} {line['how']} {line['model']} {line['ratio']:.2f}" for line in lines if line["off"]]
    other = dict.fromkeys(f"{line['drive']} {line['how']}" for line in lines if not line["same_order"])
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


def line(drive: str, how: str, model: str, true: float, found: float, order: bool) -> log.Line:
    ratio = found / true
    off = not abs(ratio - 1) <= MOST_OFF  # also for NaN
    return {"drive": drive, "how": how, "model": model, "ratio": ratio, "off": off, "same_order": order,
            "bad": off or not order, "text": f"| {drive} | {how} | {model} | {true:.4f} | {found:.4f} | {ratio:.2f} | "
                                             f"{'yes' if order else 'no'} |"}


def compare(odom: pathlib.Path, folder: pathlib.Path, part: measure.Part, recorded: bool) -> Iterator[log.Line]:
    if recorded and (part.drive in measure.VELOCITIES_ONLY or not (folder / "camera.csv").exists()):
        return
    options = ("--config", str(measure.config_of(folder)), *part.options) if recorded else ()
    with common.scratch() as work:
        blind = without_truth(folder, work)
        for how, more in (("dead reckoning", ["--dead-reckoning"]), ("camera", [])):
            true, found = rms(odom, folder, *options, *more), rms(odom, blind, *options, *more)
            order = same_order(true, found)
            yield from (line(part.name, how, model, true[model], found[model], order) for model in MODELS)


def main() -> int:
    return log.look(
        __doc__ or "",
        "| drive | | model | true rms [m] | without truth [m] | ratio | same order |\n|---|---|---|--:|--:|--:|---|",
        3, measure.JUDGED + measure.APART, COURSES, compare, headline)


if __name__ == "__main__":
    common.main(main)
