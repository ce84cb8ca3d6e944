"""Shared by the methods: running odom over seeds, and a row of the table."""

import dataclasses
import json
import math
import random
import re
import statistics
from typing import Any, NamedTuple

SIGMA_MASS, SIGMA_AXLE = 0.005, 0.0005  # typical with a scale and a tape measure
MASS, FRONT_AXLE, REAR_AXLE = 2.985, 0.175, 0.085  # nominal car of odom sim, before its errors


class Value(NamedTuple):
    """A value on one car."""
    row: str
    truth: float
    found: dict[str, Any] | None  # None if the method does not give the value
    unit: str = "%"  # of the truth, or the unit that scale converts to
    scale: float = 1.0
    bar: float | None = None  # for 2 sigma


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


def judge(values):
    """The row of a value on several cars."""
    row, _, _, unit, scale, bar = values[0]
    known = [(truth, found["value"] - truth, 2 * found["sigma"]) for _, truth, found, *_ in values
             if found and found["determined"]]

    def shown(amount, truth):
        return 100 * amount / abs(truth) if unit == "%" else amount * scale

    errors = [shown(error, truth) for truth, error, _ in known]
    return Row(what=row, inside=sum(abs(error) <= stated for _, error, stated in known), of=len(known),
               undetermined=len(values) - len(known),
               stated=max((shown(stated, truth) for truth, _, stated in known), default=math.nan),
               error=math.sqrt(statistics.fmean(error ** 2 for error in errors)) if errors else math.nan,
               unit=unit, bar=bar)


def plant_of(folder):
    return json.loads((folder / "plant.json").read_text())


def write_values(config, values):
    text = config.read_text()
    for key, value in values.items():
        text = re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
    config.write_text(text)


def weighed(truth, chance):
    """Mass and axles, as a person would measure them."""
    return {"mass": MASS * (1.0 + truth["mass_error"]) + chance.gauss(0.0, SIGMA_MASS),
            "front_axle": FRONT_AXLE + chance.gauss(0.0, SIGMA_AXLE),
            "rear_axle": REAR_AXLE + chance.gauss(0.0, SIGMA_AXLE)}


def measure_car(seed, folder):
    """Writes mass and axles into car.toml; returns the contents of plant.json."""
    plant = plant_of(folder)
    measured = weighed(plant["truth"], random.Random(seed))
    notes = {key: SIGMA_MASS if key == "mass" else SIGMA_AXLE for key in measured}
    write_values(folder / "car.toml", {key: f"{value:.5f}  # (odom identify {key}: +- {2 * notes[key]})"
                                       for key, value in measured.items()})
    return plant
