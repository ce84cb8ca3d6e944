"""odom identify mass, on a kitchen scale whose gain is not exact."""

import json

from common import output

from .rows import each, findings, judge, sample


def weigh(odom, folder, seed):
    """A simulated weighing: the truth, and what was measured."""
    output(odom, "sim", "weighing", "--force", "--seed", seed, "--out", folder)
    truth = json.loads((folder / "plant.json").read_text())["experiment"]
    return truth, json.loads((folder / "measured.json").read_text())


def run(seeds, work, odom):
    def one(seed):
        folder = work / str(seed)
        truth, measured = weigh(odom, folder, seed)
        axles = {name: value for name, value in measured.items() if name not in ("total", "left", "right")}
        (folder / "axles.json").write_text(json.dumps(axles))
        return [sample(truth["mass"], findings(odom, "mass", "--measured", folder / name)[0]["mass"])
                for name in ("measured.json", "axles.json")]

    whole, by_axles = zip(*each(seeds, one))
    return [judge("mass, as a whole", list(whole)), judge("mass, by axles", list(by_axles))]
