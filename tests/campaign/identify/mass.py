"""odom identify mass, on a kitchen scale whose gain is not exact."""

import json

from .rows import command, each, findings, judge, options, sample


def weigh(odom, folder, seed):
    """A simulated weighing: what was measured, and the truth."""
    command(odom, "sim", "weighing", "--force", "--seed", seed, "--out", folder)
    measured = json.loads((folder / "measured.json").read_text())
    truth = json.loads((folder / "plant.json").read_text())["experiment"]
    return measured, truth


def scale(measured):
    return options(**{"scale_" + name: value for name, value in measured["scale"].items()})


def run(seeds, work, odom):
    def one(seed):
        measured, truth = weigh(odom, work / str(seed), seed)
        loads = measured["loads"]
        tape = options(wheelbase=measured["wheelbase"]["value"], level=measured["level"])
        ways = {"whole": options(total=loads["total"]),
                "by axles": options(front=loads["front"], rear=loads["rear"]) + tape}
        return [sample(truth["mass"], findings(odom, "mass", *scale(measured), *way)[0]["mass"])
                for way in ways.values()]

    whole, by_axles = zip(*each(seeds, one))
    return [judge("mass, as a whole", list(whole)), judge("mass, by axles", list(by_axles))]
