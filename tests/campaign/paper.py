#!/usr/bin/env python3
"""The paper's story on simulated cars: weigh, swing, film circles, measure the noise, and drive a lap.

Every method takes the results of those before it from the configuration that they share. Each stated 2 sigma
must contain the simulator's truth on 90 % of the cars. The paper's claims on its lap must hold for the cars'
mean, with the gyro set to zero at rest, as the author's is. The table of errors by speed in docs/dev/results.md must
be what its commands give. Prints tables in Markdown. Exit status 1 if a bar is missed or the work failed,
2 on wrong usage.
"""

import json
import math
import re
import shutil
import statistics

import common
from common import ROOT, Row, output
from identify import rows
from identify.methods import STIFFNESS, findings, simulate

MODELS = ["kinematic_printed", "kinematic", "paper", "full"]
# Column heading: key in the summary, and the column's unit in terms of the summary's.
FIGURES = {"end [cm/m]": ("end_error_cm_per_m", 1.0), "heading at the end [deg]": ("heading_end", math.pi / 180),
           "35 ms [mm]": ("error_35ms_mean", 1e-3), "better than kinematic by [%]": ("better_percent", 1.0)}
CLAIMS = [("≤ 1.25", lambda end: end <= 1.25), ("≤ 2.9", lambda heading: heading <= 2.9),
          ("< 1", lambda ms: ms < 1.0), ("≥ 82.6", lambda by: by >= 82.6)]
# Error by speed in laps: options of the laps, keyed by the words of their rows, and the speeds of
# each car.
SMALL_SCALE_ERROR = "--gyro-scale-error", 0.003
DRIVEN = {"": ("--fix", "gyro_bias=0", *SMALL_SCALE_ERROR), ", with gyro bias": SMALL_SCALE_ERROR,
          ", no errors at all (`--ideal`)": ("--ideal",)}
SPEEDS = {"small car": [0.6, 1, 1.5, 2], "saloon": [5, 10, 15, 20]}


def identified(odom, work, seed):
    """Runs the chain of methods. Returns the configuration, and the values."""
    weighed = simulate(odom, work / "weighing", seed, "weighing")["experiment"]
    swung = simulate(odom, work / "swing", seed, "swing")["experiment"]
    plant = simulate(odom, work / "circles", seed, "--scenario", "circles", "--laps", 1, "--markers")
    simulate(odom, work / "standing", seed, "--standstill", 60, "--duration", 60)
    car = work / "car.toml"
    for name in "car.toml", "car.dbc":
        shutil.copy(work / "swing" / name, work / name)
    scale = "--measured", work / "weighing/measured.json"
    places = [f"--{end}={x},{y}" for end, (x, y) in plant["markers"].items()]
    found = {}
    for method, *options in (
            ("mass", *scale), ("cog", *scale),
            ("inertia", "--measured", work / "swing/measured.json", "--config", car, "--can", work / "swing/drive.log"),
            ("stiffness", "--config", car, *places, "--y-down", "--run",
             f"{work}/circles/markers.csv,{work}/circles/drive.log"),
            ("noise", "--config", car, "--can", work / "standing/drive.log")):
        found |= findings(odom, method, *options, "--write", car)
    truth = {"mass": weighed["mass"],
             "centre of gravity to front axle": weighed["front_axle"],
             "centre of gravity to rear axle": weighed["rear_axle"],
             "yaw inertia": swung["yaw_inertia"],
             **{f"cornering stiffness, {axle}": value * (1.0 + plant["truth"][f"stiffness_error_{axle}"])
                for axle, value in STIFFNESS.items()},
             "yaw_rate, noise": plant["truth"]["gyro_noise"]}
    return car, [rows.Value(name, value, found[name]) for name, value in truth.items()]


def lap_of(odom, work, options, configuration=()):
    """The magnitudes of FIGURES on the lap, by model."""
    output(odom, "sim", "--laps", 1, *options, "--force", "--out", work / "lap")
    models = [option for model in MODELS for option in ("--model", model)]
    said = json.loads(output(odom, "evaluate", "--json", "--dead-reckoning", *configuration,
                              "--drive", work / "lap", *models))
    return {row["estimate"]: [abs((row[key] or 0.0) / unit) for key, unit in FIGURES.values()]
            for row in said["summary"] if row["drive"] == "lap"}


def errors_by_speed(odom):
    """The rows of that table in docs/dev/results.md: a name, and pairs (printed figure, computed figure)."""
    text = (ROOT / "docs/dev/results.md").read_text().split("## The paper by speed")[1].split("\n## ")[0]
    car = "small car"
    for line in re.findall(r"^\| (?!\|)(.*) \|$", text, re.MULTILINE):
        name, *cells = [cell.strip() for cell in line.split(" | ")]
        if "--car" in name:
            car = "saloon"
            continue
        model, driven = re.fullmatch(r"`(\w+)`(.*)", name).groups()
        pairs = []
        for speed, cell in zip(SPEEDS[car], cells, strict=True):
            options = *DRIVEN[driven], "--speed", speed, *(("--car", car) if car == "saloon" else ())
            with common.scratch() as work:
                found = lap_of(odom, work, options)[model]
            pairs += zip(cell.split(", "), found)
        yield f"{car}, {name}", pairs


def printed_right(printed, found):
    """Whether they agree to a unit of the last digit, plus 2 % for another machine's rounding."""
    decimals = len(printed.partition(".")[2])
    return abs(float(printed) - found) <= 10 ** -decimals + 0.02 * found


def main():
    given = common.parse(common.parser(__doc__, seeds=10, what="cars"))

    def one(seed):
        with common.scratch() as work:
            car, values = identified(given.odom, work, seed)
            lap = "--fix", "gyro_bias=0", *SMALL_SCALE_ERROR, "--seed", seed
            return values, lap_of(given.odom, work, lap, ("--config", car))

    cars = common.side_by_side(given.jobs, one, [(seed,) for seed in range(1, given.seeds + 1)])
    bars = []
    for row in map(rows.judge, zip(*(values for values, _ in cars))):
        bars.append(("identified", Row(row.what, "truth within 2 sigma for 90 %",
                                       f"{row.inside} of {row.of}; rms error {row.error:.2g} %",
                                       row.undetermined == 0 and row.inside >= 0.9 * row.of)))
    means = {model: [statistics.fmean(column) for column in zip(*(laps[model] for _, laps in cars))]
             for model in MODELS}
    bars += [("lap", Row(figure, claim, f"{mean:.2f}", holds(mean)))
             for figure, mean, (claim, holds) in zip(FIGURES, means["paper"], CLAIMS)]
    for name, pairs in errors_by_speed(given.odom):
        wrong = [f"{found:.3g} for {printed}" for printed, found in pairs if not printed_right(printed, found)]
        bars.append(("errors by speed", Row(name, "as docs/dev/results.md", ", ".join(wrong) or "the same", not wrong)))
    print("\n".join(common.table(bars)))
    print(f"\n| mean of {given.seeds} laps | {' | '.join(FIGURES)} |\n|---|" + "--:|" * len(FIGURES))
    for model, figures in means.items():
        print(f"| {model} | {' | '.join(f'{mean:.2f}' for mean in figures)} |")
    return common.finish(bars)


if __name__ == "__main__":
    common.main(main)
