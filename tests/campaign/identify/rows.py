"""Shared by the methods: running odom over seeds, and a row of the table."""

import dataclasses
import json
import math
import random
import re
import statistics

from common import PROCESSORS, side_by_side

SIGMA_MASS, SIGMA_AXLE = 0.005, 0.0005  # typical with a scale and a tape measure
MASS, FRONT_AXLE, REAR_AXLE = 2.985, 0.175, 0.085  # nominal car of odom sim, before its errors


@dataclasses.dataclass(frozen=True)
class Sample:
    """One seed: the true value, and the result."""
    truth: float
    value: float
    sigma: float

    @property
    def inside(self):
        return abs(self.value - self.truth) <= 2 * self.sigma


@dataclasses.dataclass(frozen=True)
class Row:
    what: str
    inside: int
    of: int
    undetermined: int
    stated: float  # the largest stated 2 sigma, in unit
    error: float   # rms error, in unit
    unit: str      # "%" of the value, or the unit that scale converts it to
    bar: float | None

    @property
    def met(self):
        enough = self.of > 0 and self.inside >= math.ceil(0.875 * self.of)
        return enough and self.undetermined == 0 and (self.bar is None or self.stated <= self.bar)


def judge(what, samples, unit="%", scale=1.0, bar=None):
    """A row of samples; None stands for a seed for which the method did not determine the value."""
    known = [sample for sample in samples if sample is not None]

    def shown(amount, sample):
        return 100 * amount / abs(sample.truth) if unit == "%" else amount * scale

    stated = [shown(2 * sample.sigma, sample) for sample in known]
    errors = [shown(sample.value - sample.truth, sample) for sample in known]
    return Row(what=what, inside=sum(sample.inside for sample in known), of=len(known),
               undetermined=len(samples) - len(known), stated=max(stated, default=math.nan),
               error=math.sqrt(statistics.fmean(error ** 2 for error in errors)) if errors else math.nan,
               unit=unit, bar=bar)


def sample(truth, finding):
    """A finding with the true value; None if the method did not determine it."""
    if finding is None or not finding["determined"]:
        return None
    return Sample(truth, finding["value"], finding["sigma"])


def plant_of(folder):
    return json.loads((folder / "plant.json").read_text())


def write_values(config, values):
    text = config.read_text()
    for key, value in values.items():
        text = re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
    config.write_text(text)


def measure_car(seed, folder):
    """Writes mass and axles, as a person would measure them, into car.toml; returns the contents of plant.json."""
    plant = plant_of(folder)
    chance = random.Random(seed)
    measured = {"mass": MASS * (1.0 + plant["truth"]["mass_error"]) + chance.gauss(0.0, SIGMA_MASS),
                "front_axle": FRONT_AXLE + chance.gauss(0.0, SIGMA_AXLE),
                "rear_axle": REAR_AXLE + chance.gauss(0.0, SIGMA_AXLE)}
    notes = {key: SIGMA_MASS if key == "mass" else SIGMA_AXLE for key in measured}
    write_values(folder / "car.toml", {key: f"{value:.5f}  # (odom identify {key}: +- {2 * notes[key]})"
                                       for key, value in measured.items()})
    return plant


def each(seeds, work):
    """The results of work(seed) in the order of the seeds, on all processors."""
    return side_by_side(PROCESSORS, work, [(seed,) for seed in seeds])
