"""odom identify latency, on a car that drives slowly with stops, and on one on fast laps, with a camera.

Every signal is configured with a wrong age, drawn for the seed. The truth: a frame is stamped 0.3 ms after its
sample (0.25 ms on the wire, 0.05 ms of the kernel); a wheel's speed is the mean over the 10 ms before; the
steering's command is renewed every 10 ms and held, so that the wheels lag by half of that on average, less the
command's age when it is sampled. The bar holds for the drive that the guide asks for; the laps show the
results of another way to drive.
"""

import json
import random
import re

from common import output

from .rows import each, findings, judge, remove_drive, sample

BAR = 2.0  # milliseconds
MESSAGES = {"IMU": "yaw_rate accel_x accel_y", "STEERING": "steering",
            "WHEELS_FRONT": "wheel_front_left wheel_front_right",
            "WHEELS_REAR": "wheel_rear_left wheel_rear_right"}
STEERING_ID = " 1A3#"  # as in drive.log
ON_THE_WIRE, HALF_A_CYCLE, RENEWED = 0.0003, 0.005, 0.010
DRIVES = {"": (("--scenario", "stop-and-go", "--speed", 1.0, "--laps", 10), BAR),
          ", on laps": (("--scenario", "lap", "--laps", 7), None)}


def misconfigure(config, seed):
    """Gives the signals of each message an age of 0 to 20 ms."""
    chance = random.Random(seed)
    text = re.sub(r", latency = [^ ]*", "", config.read_text())
    for roles in MESSAGES.values():
        age = chance.uniform(0.0, 0.02)
        for role in roles.split():
            text = re.sub(rf"(?m)^({role} = .*) }}$", rf"\1, latency = {age:.4f} }}", text)
    config.write_text(text)


def steering_lag(log, plant):
    """True lag of the front wheels behind the stamps of the steering [s]."""
    since = plant["start_time_ns"] * 1e-9
    ages = [(float(line[1:line.index(")")]) - since - ON_THE_WIRE) % RENEWED
            for line in log.read_text().splitlines() if STEERING_ID in line]
    return plant["truth"]["steering_lag"] + RENEWED / 2 - sum(ages) / len(ages) - ON_THE_WIRE


def run(seeds, work, odom):
    for kind, (drive, bar) in DRIVES.items():
        def one(seed):
            folder = work / f"{drive[1]}-{seed}"
            output(odom, "sim", "--force", *drive, "--seed", seed, "--out", folder)
            misconfigure(folder / "car.toml", seed)
            found, _ = findings(odom, "latency", "--config", folder / "car.toml",
                                "--can", folder / "drive.log", "--camera", folder / "camera.csv")
            truth = {"latency of yaw_rate": ON_THE_WIRE,
                     "latency of wheel_front_left": ON_THE_WIRE + HALF_A_CYCLE,
                     "latency of wheel_rear_left": ON_THE_WIRE + HALF_A_CYCLE,
                     "lag of the wheels behind steering, in all":
                         steering_lag(folder / "drive.log", json.loads((folder / "plant.json").read_text()))}
            remove_drive(folder)
            return {name: sample(value, found[name]) for name, value in truth.items()}

        samples = each(seeds, one)
        for name in samples[0]:
            what = name.removesuffix("_left").replace("latency of", "latency:").replace("behind steering, in all", "behind the steering")
            yield judge(what + kind, [each_seed[name] for each_seed in samples], unit="ms", scale=1e3, bar=bar)
