"""odom identify noise: of a car that stands for ten minutes, and of one that drives a minute."""

import json
import math

from common import output

from .rows import each, findings, judge, sample

STANDING = 600  # seconds
RATE_STEP, ACCEL_STEP = 0.0002, 0.0025  # resolutions of the signals in odomd.dbc
WHEEL_RADIUS, CYCLE = 0.033, 0.01  # assumed by the simulated control units
WHEELS = "wheel_front_left", "wheel_front_right", "wheel_rear_left", "wheel_rear_right"

BIASES = {"yaw_rate, bias": ("mrad/s", 1e3), "accel_x, bias": ("m/s2", 1.0), "accel_y, bias": ("m/s2", 1.0)}


def standing_truth(truth):
    """The true values in plant.json, by the names of the findings."""
    accel = math.hypot(truth["accel_noise"], ACCEL_STEP / math.sqrt(12))
    return {"yaw_rate, noise": math.hypot(truth["gyro_noise"], RATE_STEP / math.sqrt(12)),
            "accel_x, noise": accel, "accel_y, noise": accel,
            "yaw_rate, bias": truth["gyro_bias"],
            "accel_x, bias": truth["accel_bias_x"], "accel_y, bias": truth["accel_bias_y"],
            "yaw_rate, bias walk": truth["gyro_bias_walk"],
            "accel_x, bias walk": truth["accel_bias_walk"],
            "accel_y, bias walk": truth["accel_bias_walk"]}


def driving_truth(truth):
    count = 2 * math.pi * WHEEL_RADIUS / truth["encoder_counts"] / CYCLE
    wheel = math.hypot(truth["wheel_noise"], count / math.sqrt(6))
    accel = math.hypot(truth["accel_noise"], ACCEL_STEP / math.sqrt(12))
    return {"yaw_rate, noise on the move": math.hypot(truth["gyro_noise"], RATE_STEP / math.sqrt(12)),
            "accel_x, noise on the move": accel, "accel_y, noise on the move": accel,
            **{f"{name}, noise on the move": wheel for name in WHEELS}}


def truth_of(folder):
    return json.loads((folder / "plant.json").read_text())["truth"]


def run(seeds, work, odom):
    def stand(seed):
        folder = work / f"standing-{seed}"
        output(odom, "sim", "--force", "--standstill", STANDING, "--duration", STANDING, "--seed", seed,
                "--out", folder)
        found, _ = findings(odom, "noise", "--config", folder / "car.toml", "--can", folder / "drive.log")
        for file in "drive.log", "truth.csv", "camera.csv":
            (folder / file).unlink()  # 25 MB
        return {name: sample(truth, found[name])
                for name, truth in standing_truth(truth_of(folder)).items()}

    def drive(seed):
        folder = work / f"driving-{seed}"
        output(odom, "sim", "--force", "--scenario", "slalom", "--seed", seed, "--out", folder)
        found, _ = findings(odom, "noise", "--drive", folder)
        return {name: sample(truth, found[name])
                for name, truth in driving_truth(truth_of(folder)).items()}

    rows = []
    for kind, experiment in ("standing", stand), ("driving", drive):
        all_samples = each(seeds, experiment)
        for name in all_samples[0]:
            unit, scale = BIASES.get(name, ("%", 1.0))
            rows.append(judge(f"noise, {kind}: {name}", [samples[name] for samples in all_samples],
                              unit=unit, scale=scale))
    return rows
