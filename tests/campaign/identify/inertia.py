"""odom identify inertia, on a rigid body in space on two springy cords: with its gyro, and with a stop-watch.
The car is weighed first.
"""

import json

from common import output

from .mass import weigh
from .rows import each, findings, judge, sample

BAR = 2.0  # per cent


def run(seeds, work, odom):
    def one(seed):
        scale, swing = work / f"scale{seed}", work / str(seed)
        weigh(odom, scale, seed)
        output(odom, "sim", "swing", "--force", "--seed", seed, "--out", swing)
        car = swing / "car.toml"
        output(odom, "identify", "mass", "--measured", scale / "measured.json", "--write", car)
        truth = json.loads((swing / "plant.json").read_text())["experiment"]["yaw_inertia"]
        measured = "--measured", swing / "measured.json", "--config", car
        gyro, _ = findings(odom, "inertia", *measured, "--can", swing / "drive.log")
        timed, _ = findings(odom, "inertia", *measured)
        return sample(truth, gyro["yaw inertia"]), sample(truth, timed["yaw inertia"])

    gyro, timed = zip(*each(seeds, one))
    return [judge("inertia, by gyro", list(gyro), bar=BAR),
            judge("inertia, by stop-watch", list(timed), bar=BAR)]
