"""odom identify stiffness, of circles filmed from above: odom sim --scenario circles --markers.

The method gets what a person would know: mass to 5 g, axles to 0.5 mm, the markers' places to
1 mm (drawn by the simulator); the film lies somewhere in the log, with half a pixel of noise and a clock of
its own. The truth is the slope of the plant's tyres at zero slip under static load.
"""

import json

from common import output

from .rows import SIGMA_AXLE, SIGMA_MASS, each, findings, judge, measure_car, remove_drive, sample

BAR = 5.0  # per cent
SIGMA_MARKER = 0.001
CONFIGURED = {"front": 20.0, "rear": 60.0}


def measure(seed, folder):
    """Writes what was measured into car.toml; returns the truth and the method's other options."""
    plant = measure_car(seed, folder)
    options = ["--config", folder / "car.toml", "--sigma-mass", SIGMA_MASS, "--sigma-axle", SIGMA_AXLE,
               "--sigma-marker", SIGMA_MARKER]
    options += [f"--{end}={x},{y}" for end, (x, y) in plant["markers"].items()]
    truth = {axle: value * (1.0 + plant["truth"][f"stiffness_error_{axle}"])
             for axle, value in CONFIGURED.items()}
    return truth, options


def begin_of_film(folder):
    """Time of the film's first frame after the log's first frame [s]."""
    plant = json.loads((folder / "plant.json").read_text())
    with open(folder / "drive.log", encoding="ascii") as log:
        second, digits = log.readline().split(")")[0].lstrip("(").split(".")
    first = int(second) * 10**9 + int(digits.ljust(9, "0"))
    return abs(plant["truth"]["film_begin"]) - 1e-9 * (first - plant["start_time_ns"])


def run(seeds, work, odom):
    def one(seed):
        folder = work / str(seed)
        output(odom, "sim", "--scenario", "circles", "--markers", "--force", "--seed", seed,
                "--out", folder)
        truth, options = measure(seed, folder)
        found, _ = findings(odom, "stiffness", *options, "--y-down",
                            "--run", f"{folder}/markers.csv,{folder}/drive.log")
        begin = begin_of_film(folder)
        remove_drive(folder)
        return [*(sample(truth[axle], found[f"cornering stiffness, {axle}"]) for axle in CONFIGURED),
                sample(begin, found["begin of the film after the log"])]

    front, rear, begins = zip(*each(seeds, one))
    return [judge("cornering stiffness, front", list(front), bar=BAR),
            judge("cornering stiffness, rear", list(rear), bar=BAR),
            judge("begin of the film in the log", list(begins), unit="ms", scale=1e3)]
