"""odom identify track, and then stiffness, on one rendered film of simulated circles.

A perspective camera with a lens, a little askew, 25 frames a second of 1280 x 720, noise of 3 grey levels;
ArUco markers of 10 cm on the car and of 22 cm on the ground. Needs odom-track. One seed: the film takes
minutes.
"""

import shlex

from common import output

from .rows import findings, judge, sample
from .stiffness import BAR, CONFIGURED, measure


def run(seeds, work, odom):
    seed = seeds[0]
    folder = work / str(seed)
    film = work / "film.avi"
    said = output(odom, "sim", "--scenario", "circles", "--laps", 1, "--force", "--seed", seed,
                   "--film", film, "--film-rate", 25, "--out", folder)
    truth, options = measure(seed, folder)
    track = shlex.split(said.split("to track it: odom ")[1])
    output(odom, *track, "--out", folder / "markers.csv")
    film.unlink()
    found, _ = findings(odom, "stiffness", *options, "--metres",
                        "--run", f"{folder}/markers.csv,{folder}/drive.log")
    return [judge(f"cornering stiffness by film, {axle}",
                  [sample(truth[axle], found[f"cornering stiffness, {axle}"])], bar=BAR)
            for axle in CONFIGURED]
