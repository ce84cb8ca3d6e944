"""odom identify fit, on the drive that its help describes: odom sim --scenario exercise.

The fit starts from what a person would know: mass to 5 g, axles to 0.5 mm; stiffnesses, inertia
and sensors as configured. The true yaw inertia is that of all that turns with the car: the body's, and
I (t / 2 r)^2 for the spin of each wheel and motor, which a pendulum does not show. The true latency is
that of the simulated bus: a frame takes 0.25 ms and is stamped 0.05 ms later, and a wheel's speed is
the mean over the 10 ms before.
"""

from common import output

from .rows import MASS, SIGMA_MASS, each, findings, judge, measure_car, remove_drive, sample

INERTIA, TRACK, RADIUS = 0.0283384, 0.16, 0.033
WHEEL, MOTOR = 3.3e-5, 6e-5  # kg m^2, as in tools/sim/car/vehicle.cpp
FRAME = 0.3e-3


def rows_of(truth):
    """The evaluated values: name in the fit, true value, and how judge() prints and compares them."""
    spin = (4 * WHEEL + 2 * MOTOR) * (TRACK / 2.0 / RADIUS) ** 2
    radius = 1.0 + truth["wheel_radius_error"]
    return [
        ("cornering stiffness, front", 20.0 * (1.0 + truth["stiffness_error_front"]), {"bar": 5.0}),
        ("cornering stiffness, rear", 60.0 * (1.0 + truth["stiffness_error_rear"]), {"bar": 5.0}),
        ("yaw inertia", INERTIA * (1.0 + truth["inertia_error"]) + spin, {"bar": 2.0}),
        ("latency of yaw_rate", FRAME, {"unit": "ms", "scale": 1e3, "bar": 2.0}),
        ("latency of wheel_front_left", 5e-3 + FRAME, {"unit": "ms", "scale": 1e3, "bar": 2.0}),
        ("latency of wheel_rear_left", 5e-3 + FRAME, {"unit": "ms", "scale": 1e3, "bar": 2.0}),
        ("gyro scale", 1.0 / (1.0 + truth["gyro_scale_error"]), {}),
        ("steering offset", -truth["steering_offset"] / (1.0 + truth["steering_scale_error"]),
         {"unit": "mrad", "scale": 1e3}),
        ("steering scale", 1.0 / (1.0 + truth["steering_scale_error"]), {}),
        ("wheel scale, rear left", radius * (1.0 + truth["wheel_radius_error_rear_left"]), {}),
        ("IMU ahead of the centre of gravity", truth["imu_x"], {"unit": "mm", "scale": 1e3}),
        ("IMU mounting yaw", truth["imu_yaw_error"], {"unit": "mrad", "scale": 1e3}),
        ("camera's point ahead of the centre of gravity", 0.0, {"unit": "mm", "scale": 1e3}),
    ]


def run(seeds, work, odom):
    def one(seed):
        folder = work / str(seed)
        output(odom, "sim", "--scenario", "exercise", "--force", "--seed", seed, "--out", folder)
        truth = measure_car(seed, folder)["truth"]
        found, _ = findings(odom, "fit", "--quiet", "--config", folder / "car.toml", "--drive", folder,
                            "--prior", f"mass={SIGMA_MASS / MASS}")
        remove_drive(folder)
        return [(name, sample(true, found.get(name)), printed) for name, true, printed in rows_of(truth)]

    return [judge("fit: " + column[0][0], [seen for _, seen, _ in column], **column[0][2])
            for column in zip(*each(seeds, one))]
