"""The methods of odom identify on one simulated car each: functions of (odom, work, seed) that yield a Value for each
row of the table. They make folders of their own in `work`.
"""

import json
import math
import random
import re
import shlex

from common import output, side_by_side

from .rows import MASS, SIGMA_MASS, Value, judge, measure_car, plant_of

# The configured car of odom sim, before its errors.
INERTIA, TRACK, RADIUS = 0.0283384, 0.16, 0.033
STIFFNESS = {"front": 20.0, "rear": 60.0}
WHEEL, MOTOR = 3.3e-5, 6e-5  # kg m^2, as in tools/sim/car/cars.cpp
ON_THE_WIRE = 0.3e-3  # a frame takes 0.25 ms and is stamped 0.05 ms later
CYCLE = 0.01  # s, of the control units: wheel speeds are means over a cycle, the steering command is held for one


def rows_of(method, seeds, work, given):
    """The rows of a method over the cars."""
    cars = side_by_side(given.jobs, lambda seed: list(method(given.odom, work, seed)), [(seed,) for seed in seeds])
    return map(judge, zip(*cars))


def simulate(odom, folder, seed, *options):
    """Returns the contents of plant.json."""
    output(odom, "sim", *options, "--force", "--seed", seed, "--out", folder)
    return plant_of(folder)


def findings(odom, method, *options):
    """The values of odom identify METHOD by their names."""
    said = json.loads(output(odom, "identify", method, "--json", *options))
    return {value["name"]: value for value in said["values"]}


def remove_drive(folder):
    """Removes the large files of a seed after its evaluation."""
    for name in ("drive.log", "truth.csv", "camera.csv"):
        (folder / name).unlink()


def mass(odom, work, seed):
    """Weighs the car on a kitchen scale whose gain is not exact."""
    folder = work / str(seed)
    truth = simulate(odom, folder, seed, "weighing")["experiment"]["mass"]
    measured = json.loads((folder / "measured.json").read_text())
    axles = {name: value for name, value in measured.items() if name not in ("total", "left", "right")}
    (folder / "axles.json").write_text(json.dumps(axles))
    for how, file in (("as a whole", "measured.json"), ("by axles", "axles.json")):
        yield Value(f"mass, {how}", truth, findings(odom, "mass", "--measured", folder / file)["mass"])


def cog(odom, work, seed):
    """Measures with a tape; the car is never quite level."""
    folder = work / str(seed)
    truth = simulate(odom, folder, seed, "weighing")["experiment"]
    found = findings(odom, "cog", "--measured", folder / "measured.json")
    for key, name in (("front_axle", "to front axle"), ("rear_axle", "to rear axle"), ("lateral", "left of the middle")):
        yield Value(f"cog: {key}", truth[key], found[f"centre of gravity {name}"], "mm", 1e3)


def inertia(odom, work, seed):
    """Weighs the car, then swings it as a rigid body on two elastic cords: with its gyro, and with a stop-watch."""
    scale, swing = work / f"scale{seed}", work / str(seed)
    simulate(odom, scale, seed, "weighing")
    truth = simulate(odom, swing, seed, "swing")["experiment"]["yaw_inertia"]
    car = swing / "car.toml"
    output(odom, "identify", "mass", "--measured", scale / "measured.json", "--write", car)
    for how, log in (("gyro", ["--can", swing / "drive.log"]), ("stop-watch", [])):
        found = findings(odom, "inertia", "--measured", swing / "measured.json", "--config", car, *log)
        yield Value(f"inertia, by {how}", truth, found["yaw inertia"], bar=2.0)


def quantised(sigma, step):
    """The noise of a signal with this resolution."""
    return math.hypot(sigma, step / math.sqrt(12))


def noises(truth):
    """The noise of gyro and accelerometers, with the resolutions in odomd.dbc."""
    accel = quantised(truth["accel_noise"], 0.0025)
    return {"yaw_rate": quantised(truth["gyro_noise"], 0.0002), "accel_x": accel, "accel_y": accel}


def standing_noise(odom, work, seed):
    """Measures the noise of a car that stands for ten minutes."""
    folder = work / f"standing-{seed}"
    truth = simulate(odom, folder, seed, "--standstill", 600, "--duration", 600)["truth"]
    found = findings(odom, "noise", "--config", folder / "car.toml", "--can", folder / "drive.log")
    remove_drive(folder)  # 25 MB

    def value(name, true, unit="%", scale=1.0):
        return Value(f"noise, standing: {name}", true, found[name], unit, scale)

    for signal, noise in noises(truth).items():
        yield value(f"{signal}, noise", noise)
    yield value("yaw_rate, bias", truth["gyro_bias"], "mrad/s", 1e3)
    for signal in ("accel_x", "accel_y"):
        yield value(f"{signal}, bias", truth[signal.replace("_", "_bias_")], "m/s2")
    yield value("yaw_rate, bias walk", truth["gyro_bias_walk"])
    for signal in ("accel_x", "accel_y"):
        yield value(f"{signal}, bias walk", truth["accel_bias_walk"])


def measure_for_stiffness(seed, folder):
    """Writes into car.toml what a person would know: mass to 5 g, axles to 0.5 mm; the markers' places to 1 mm.

    Returns the truth (the slope of the plant's tyres at zero slip under static load), and the
    method's other options."""
    plant = measure_car(seed, folder)
    options = ["--config", folder / "car.toml", "--sigma-marker", 0.001]
    options += [f"--{end}={x},{y}" for end, (x, y) in plant["markers"].items()]
    return {axle: value * (1.0 + plant["truth"][f"stiffness_error_{axle}"]) for axle, value in STIFFNESS.items()}, options


def stiffness(odom, work, seed):
    """Films circles from above. The film starts somewhere in the log, with half a pixel of noise and its own clock."""
    folder = work / str(seed)
    plant = simulate(odom, folder, seed, "--scenario", "circles", "--markers")
    truth, options = measure_for_stiffness(seed, folder)
    found = findings(odom, "stiffness", *options, "--y-down", "--run", f"{folder}/markers.csv,{folder}/drive.log")
    with open(folder / "drive.log", encoding="ascii") as log:
        second, digits = log.readline().split(")")[0].lstrip("(").split(".")
    first_ns = int(second) * 10**9 + int(digits.ljust(9, "0"))
    remove_drive(folder)
    for axle, true in truth.items():
        yield Value(f"cornering stiffness, {axle}", true, found[f"cornering stiffness, {axle}"], bar=5.0)
    begin = abs(plant["truth"]["film_begin"]) - 1e-9 * (first_ns - plant["start_time_ns"])
    yield Value("begin of the film in the log", begin, found["begin of the film after the log"], "ms", 1e3)


def track(odom, work, seed):
    """odom identify track, and then stiffness, on one rendered film of simulated circles.

    A perspective camera with a lens, a little askew, 25 frames a second of 1280 x 720, noise of 3 grey levels; ArUco
    markers of 10 cm on the car and of 22 cm on the ground. Needs odom-track. The film takes minutes."""
    folder, film = work / str(seed), work / "film.avi"
    said = output(odom, "sim", "--scenario", "circles", "--laps", 1, "--force", "--seed", seed,
                  "--film", film, "--film-rate", 25, "--out", folder)
    truth, options = measure_for_stiffness(seed, folder)
    output(odom, *shlex.split(said.split("to track it: odom ")[1]), "--out", folder / "markers.csv")
    film.unlink()
    found = findings(odom, "stiffness", *options, "--metres", "--run", f"{folder}/markers.csv,{folder}/drive.log")
    for axle, true in truth.items():
        yield Value(f"cornering stiffness by film, {axle}", true, found[f"cornering stiffness, {axle}"], bar=5.0)


def misconfigure(config, seed):
    """Configures a random latency of 0 to 20 ms for the signals of each message."""
    chance = random.Random(seed)
    text = re.sub(r", latency = [^ ]*", "", config.read_text())
    for roles in ("yaw_rate|accel_x|accel_y", "steering", "wheel_front_left|wheel_front_right",
                  "wheel_rear_left|wheel_rear_right"):
        text = re.sub(rf"(?m)^((?:{roles}) = .*) }}$", rf"\1, latency = {chance.uniform(0.0, 0.02):.4f} }}", text)
    config.write_text(text)


def steering_lag(log, plant):
    """True lag of the front wheels behind the stamps of the steering [s]: half a cycle of the command on average, less
    the command's age when it is sampled."""
    since = plant["start_time_ns"] * 1e-9
    ages = [(float(line[1:line.index(")")]) - since - ON_THE_WIRE) % CYCLE
            for line in log.read_text().splitlines() if " 1A3#" in line]
    return plant["truth"]["steering_lag"] + CYCLE / 2 - sum(ages) / len(ages) - ON_THE_WIRE


def latency_of(drive, rows_end, bar):
    """odom identify latency on a drive with a camera. Every signal is configured with a wrong age, drawn for the seed."""
    def latency(odom, work, seed):
        folder = work / f"{drive[1]}-{seed}"
        plant = simulate(odom, folder, seed, *drive)
        misconfigure(folder / "car.toml", seed)
        found = findings(odom, "latency", "--config", folder / "car.toml", "--can", folder / "drive.log",
                         "--camera", folder / "camera.csv")
        truth = {"latency of yaw_rate": ("latency: yaw_rate", ON_THE_WIRE),
                 "latency of wheel_front_left": ("latency: wheel_front", ON_THE_WIRE + CYCLE / 2),
                 "latency of wheel_rear_left": ("latency: wheel_rear", ON_THE_WIRE + CYCLE / 2),
                 "lag of the wheels behind steering, in all":
                     ("lag of the wheels behind the steering", steering_lag(folder / "drive.log", plant))}
        remove_drive(folder)
        for name, (row, true) in truth.items():
            yield Value(row + rows_end, true, found[name], "ms", 1e3, bar)
    return latency


def fit(odom, work, seed):
    """Fits the drive that its help describes, starting from what a person would know: mass to 5 g, axles to 0.5 mm;
    stiffnesses, inertia and sensors as configured. The true yaw inertia includes everything that turns with the car:
    the body, and I (t / 2 r)^2 for the spin of each wheel and motor, which a pendulum does not show."""
    folder = work / str(seed)
    simulate(odom, folder, seed, "--scenario", "exercise")
    truth = measure_car(seed, folder)["truth"]
    found = findings(odom, "fit", "--quiet", "--config", folder / "car.toml", "--drive", folder,
                     "--prior", f"mass={SIGMA_MASS / MASS}")
    remove_drive(folder)
    spin = (4 * WHEEL + 2 * MOTOR) * (TRACK / 2.0 / RADIUS) ** 2
    wheel_scale = (1.0 + truth["wheel_radius_error"]) * (1.0 + truth["wheel_radius_error_rear_left"])
    steering_scale = 1.0 / (1.0 + truth["steering_scale_error"])
    for name, *rest in (
            *((f"cornering stiffness, {axle}", value * (1.0 + truth[f"stiffness_error_{axle}"]), "%", 1.0, 5.0)
              for axle, value in STIFFNESS.items()),
            ("yaw inertia", INERTIA * (1.0 + truth["inertia_error"]) + spin, "%", 1.0, 2.0),
            ("latency of yaw_rate", ON_THE_WIRE, "ms", 1e3, 2.0),
            ("latency of wheel_front_left", CYCLE / 2 + ON_THE_WIRE, "ms", 1e3, 2.0),
            ("latency of wheel_rear_left", CYCLE / 2 + ON_THE_WIRE, "ms", 1e3, 2.0),
            ("gyro scale", 1.0 / (1.0 + truth["gyro_scale_error"])),
            ("steering offset", -truth["steering_offset"] * steering_scale, "mrad", 1e3),
            ("steering scale", steering_scale),
            ("wheel scale, rear left", wheel_scale),
            ("IMU ahead of the centre of gravity", truth["imu_x"], "mm", 1e3),
            ("IMU mounting yaw", truth["imu_yaw_error"], "mrad", 1e3),
            ("camera's point ahead of the centre of gravity", 0.0, "mm", 1e3)):
        yield Value(f"fit: {name}", rest[0], found.get(name), *rest[1:])


# The bar on latency holds for the drive that the guide asks for; the laps show another way to drive.
METHODS = {"mass": [mass], "cog": [cog], "inertia": [inertia], "noise": [standing_noise],
           "track": [track], "stiffness": [stiffness],
           "latency": [latency_of(("--scenario", "stop-and-go", "--speed", 1.0, "--laps", 10), "", 2.0),
                       latency_of(("--scenario", "lap", "--laps", 7), ", on laps", None)],
           "fit": [fit]}
ONE_SEED = ("track",)
