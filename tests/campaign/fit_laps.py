#!/usr/bin/env python3
"""The gain of `odom identify fit` on one lap with a camera for other laps, compared with measuring by hand.

Each of the simulated cars has a configuration by hand, as measured with scale, cords and film: mass to 5 g,
axles to 0.5 mm, stiffnesses to 1.5 %, yaw inertia to 0.5 % (standard uncertainties), the sensors as in their data
sheets. The fit starts from it, knows these uncertainties, and gets one lap at 1.5 m/s with its camera. Other laps
of the same car, at other speeds and with the biases of another start, are replayed by dead reckoning with both
configurations. The table is Markdown; docs/dev/results.md has the figures that matter. Exit status 1 if the fit
does not lower the errors of each lap, as a geometric mean over the cars.
"""
import pathlib
import random
import shutil
import statistics
import sys

import common
from common import DEGREES, output
from identify import rows
from identify.methods import INERTIA, STIFFNESS, simulate
from recorded import measure

OTHERS = {"lap at 1 m/s": ("lap", 1.0, 1), "lap at 2 m/s": ("lap", 2.0, 1), "three laps at 2.5 m/s": ("lap", 2.5, 3),
          "slalom at 1.5 m/s": ("slalom", 1.5, 1)}
ERRORS = {"35 ms, mean": (1e3, lambda e: e["error_35ms"]["position"]["mean"]),  # factor to the table's unit; error
          "position, rms": (1e3, lambda e: e["position"]["rms"]),
          "end": (1e3, lambda e: e["end_error"]),
          "heading, rms": (DEGREES, lambda e: e["heading"]["rms"])}


def measured_by_hand(config: pathlib.Path, truth: dict, chance: random.Random) -> None:
    values = rows.weighed(truth, chance)
    values["yaw_inertia"] = INERTIA * (1.0 + truth["inertia_error"]) * (1.0 + chance.gauss(0.0, 0.005))
    for axle, value in STIFFNESS.items():
        true = value * (1.0 + truth[f"stiffness_error_{axle}"])
        values[f"cornering_stiffness_{axle}"] = true * (1.0 + chance.gauss(0.0, 0.015))
    rows.write_values(config, {key: f"{value:.6g}" for key, value in values.items()})


def judged(odom: pathlib.Path, config: pathlib.Path, folder: pathlib.Path) -> dict:
    estimate = measure.dead_reckoning(odom, config, folder, folder)
    return {name: error(estimate) for name, (_, error) in ERRORS.items()}


def car(odom: pathlib.Path, seed: int, work: pathlib.Path) -> dict:
    """Errors of each lap, by hand and fitted."""
    def drive(folder: pathlib.Path, scenario: str, speed: float, laps: int, *more: object) -> dict:
        return simulate(odom, folder, seed, "--scenario", scenario, "--speed", speed, "--laps", laps, *more)

    chance = random.Random(seed)
    taught = work / f"{seed}"
    by_hand, fitted = taught / "car.toml", taught / "fitted.toml"
    measured_by_hand(by_hand, drive(taught, "lap", 1.5, 1)["truth"], chance)
    shutil.copy(by_hand, fitted)
    output(odom, "identify", "fit", "--quiet", "--config", by_hand, "--drive", taught, "--prior", "mass=0.0017",
           "--prior", "stiffness_front=0.015", "--prior", "stiffness_rear=0.015", "--prior", "yaw_inertia=0.005",
           "--write", fitted)
    result = {}
    for k, (name, course) in enumerate(OTHERS.items()):
        other = work / f"{seed}-{k}"
        drive(other, *course, "--fix", f"gyro_bias={chance.gauss(0.0, 0.0122):.6f}",
              "--fix", f"accel_bias_x={chance.gauss(0.0, 0.1):.4f}", "--fix", f"accel_bias_y={chance.gauss(0.0, 0.1):.4f}")
        result[name] = (judged(odom, by_hand, other), judged(odom, fitted, other))
        shutil.rmtree(other)
    print(f"fit_laps: car {seed} done", file=sys.stderr)
    return result


def main() -> int:
    given = common.parse(common.parser(__doc__ or "", seeds=8, what="cars"))
    with common.scratch() as work:
        cars = common.side_by_side(given.jobs, car, [(given.odom, seed, work) for seed in range(1, given.seeds + 1)])
    print(f"Fitted on one lap, {len(cars)} cars, {common.BEGUN:%F}; medians, by hand > fitted "
          "(geometric mean of the ratios; cars that do better):\n")
    print("| judged on | 35 ms mean [mm] | position rms [mm] | end [mm] | heading rms [°] |")
    print("|---|---|---|---|---|")
    lowered = True
    for lap in OTHERS:
        cells = []
        for error, (unit, _) in ERRORS.items():
            pairs = [(c[lap][0][error], c[lap][1][error]) for c in cars]
            ratio = common.geometric_mean([after / before for before, after in pairs])
            better = sum(after < before for before, after in pairs)
            cells.append(f"{unit * statistics.median(b for b, _ in pairs):.2f} > "
                         f"{unit * statistics.median(a for _, a in pairs):.2f} ({ratio:.2f}; {better})")
            if error in ("35 ms, mean", "position, rms"):
                lowered = lowered and ratio < 1.0
        print(f"| {lap} | {' | '.join(cells)} |", flush=True)
    return 0 if lowered else 1


if __name__ == "__main__":
    common.main(main)
