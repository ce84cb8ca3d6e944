"""The courses: scenarios of odom sim with their options, and the parts of each drive to evaluate."""

import dataclasses

SPEEDS = (1.0, 1.5, 2.0, 2.5)  # m/s, in laps
GAP_SPEED = 1.5
GAPS = tuple((begin, 2.0) for begin in (20, 28, 36, 44, 52))  # begin and length of drop-outs [s]
LATEST = 0.05  # s; a lost camera's poses have all arrived by then
FOREVER = 10000  # s

CALIBRATED = ("--gyro-scale-error", "0.003")  # as after a calibration; otherwise 3 %, for the camera to learn
# A gyro with the usual noise at rest, and five times that while moving.
SHAKEN = ("--noise-at-rest", "0.2", "--gyro-noise", "0.025")
MANOEUVRES = ("stop-and-go", "slalom", "parking", "patch")


@dataclasses.dataclass(frozen=True)
class View:
    """One evaluation of a drive: of the replay with or without the camera's poses, with these options of odom evaluate.
    `metres`: it ends this far after its begin."""

    camera: bool = False
    compared: bool = True  # whether to evaluate the other models, too
    align: str = "first"
    frame: str = "map"
    begin: float | None = None  # s after the start of the drive
    end: float | None = None
    metres: float | None = None


MAP = View(camera=True, align="none")


@dataclasses.dataclass(frozen=True)
class Course:
    name: str
    options: tuple[str, ...]  # options of odom sim
    views: dict[str, View]
    shift: bool = False  # whether to replay again with all stamps a microsecond later
    seeds_after: int = 0


def lap(speed, *options):
    return ("--scenario", "lap", "--speed", f"{speed:g}", "--duration", "60", *options)


def without_camera(name, *options):
    return Course(name, (*options, *CALIBRATED), {"whole": View()})


def with_camera(name, *options, shift=False, **views):
    return Course(name, options, {"map": MAP, **views}, shift=shift)


def lost(name, speed, begin, **views):
    return Course(name, lap(speed, "--camera-dropout", f"{begin}:{FOREVER}"), views)


def shaken_lap(speed):
    """A lap of a minute after 3 s at rest, with a gyro whose scale is exact."""
    exact = ("--scenario", "lap", "--speed", f"{speed:g}", "--duration", "63", "--gyro-scale-error", "0")
    return Course(f"shaken-lap-{speed:g}", (*exact, *SHAKEN), {"whole": View()})


def all_courses(speeds=SPEEDS):
    for speed in speeds:
        yield without_camera(f"lap-{speed:g}", *lap(speed))
    for scenario in MANOEUVRES:
        yield without_camera(scenario, "--scenario", scenario)
    for speed in speeds:
        yield with_camera(f"camera-lap-{speed:g}", *lap(speed), shift=True,
                          odom=View(camera=True, frame="odom", begin=10))
        yield with_camera(f"outliers-lap-{speed:g}", *lap(speed, "--camera-outliers", "0.01"))
        yield lost(f"lost-10-lap-{speed:g}", speed, 10, after=View(camera=True, begin=10 + LATEST))
        yield lost(f"lost-15-lap-{speed:g}", speed, 15, after=View(camera=True, begin=15 + LATEST, metres=20))
    for scenario in MANOEUVRES:
        yield with_camera(f"camera-{scenario}", "--scenario", scenario)
    dropouts = [word for begin, length in GAPS for word in ("--camera-dropout", f"{begin}:{length:g}")]
    yield with_camera("gaps-lap", *lap(GAP_SPEED, *dropouts), **{
        f"gap-{begin}": dataclasses.replace(MAP, begin=begin, end=begin + length + LATEST)
        for begin, length in GAPS})
    for speed in speeds:
        yield shaken_lap(speed)
