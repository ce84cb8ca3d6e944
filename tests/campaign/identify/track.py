"""odom identify track and stiffness after it, of one film rendered of simulated circles.

A perspective camera with a lens, a little askew, 25 frames a second of 1280 x 720, noise of 3 grey levels;
ArUco markers of 10 cm on the car and of 22 cm on the ground. Needs odom-track and the test programs. One
seed: the film takes minutes.
"""

import json
import subprocess

from .rows import Failed, command, findings, judge, sample
from .stiffness import BAR, CONFIGURED, measure

BEGIN, RATE = 1.3, 25.0  # of the film: s after the log, frames a second
HEIGHT = 0.08
GROUND = {0: (-1.8, -3.3), 1: (-1.8, 3.3), 2: (1.8, -3.3), 3: (1.8, 3.3)}


def run(seeds, work, odom):
    seed = seeds[0]
    folder = work / str(seed)
    command(odom, "sim", "--scenario", "circles", "--laps", 1, "--force", "--seed", seed, "--out", folder)
    truth, options = measure(seed, folder)
    places = json.loads((folder / "plant.json").read_text())["markers"]
    film = folder / "film.avi"
    renderer = odom.parent / "render_circles"
    made = subprocess.run([renderer, folder / "truth.csv", film, str(BEGIN), str(RATE),
                           *(str(value) for end in ("front", "rear") for value in places[end])],
                          capture_output=True, text=True, check=False)
    if made.returncode != 0:
        raise Failed(f"{renderer}: {made.stderr.strip()}")
    ground = [f"--ground-marker={marker}={x},{y}" for marker, (x, y) in GROUND.items()]
    command(odom, "identify", "track", film, "--lens", f"{film}.yaml", "--aruco", "4x4_50", "--front", 7,
            "--rear", 8, "--height", HEIGHT, *ground, "--out", folder / "markers.csv")
    film.unlink()
    found, _ = findings(odom, "stiffness", *options, "--metres",
                        "--run", f"{folder}/markers.csv,{folder}/drive.log")
    return [judge(f"cornering stiffness by film, {axle}",
                  [sample(truth[axle], found[f"cornering stiffness, {axle}"])], bar=BAR)
            for axle in CONFIGURED]
