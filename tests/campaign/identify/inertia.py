"""odom identify inertia, of a rigid body in space on two springy cords: by its gyro, and by stop-watch."""

import json

from .rows import command, each, findings, judge, options, sample

BAR = 2.0  # per cent


def run(seeds, work, odom):
    def one(seed):
        folder = work / str(seed)
        command(odom, "sim", "swing", "--force", "--seed", seed, "--out", folder)
        measured = json.loads((folder / "measured.json").read_text())
        truth = json.loads((folder / "plant.json").read_text())["experiment"]["yaw_inertia"]
        rig = options(mass=measured["mass"]["value"], mass_sigma=measured["mass"]["sigma"],
                      spacing=measured["spacing"]["value"],
                      spacing_below=measured["spacing_below"]["value"],
                      spacing_sigma=measured["spacing"]["sigma"],
                      cord=measured["cord"]["value"], cord_sigma=measured["cord"]["sigma"],
                      offset_sigma=measured["offset_sigma"])
        gyro, _ = findings(odom, "inertia", *rig, "--config", folder / "car.toml",
                           "--can", folder / "drive.log")
        watch = measured["stop_watch"]
        timed, _ = findings(odom, "inertia", *rig,
                            *options(swings=watch["swings"], time=watch["times"],
                                     time_sigma=watch["sigma"], amplitude=measured["amplitude"],
                                     amplitude_end=measured["amplitude_end"]))
        return sample(truth, gyro["yaw inertia"]), sample(truth, timed["yaw inertia"])

    gyro, timed = zip(*each(seeds, one))
    return [judge("inertia, by gyro", list(gyro), bar=BAR),
            judge("inertia, by stop-watch", list(timed), bar=BAR)]
