"""The full-size cars of odom sim: what they drive, and the bars that a model is held to there.

A ratio divides a drive's figure for the model by that for the reference model; the geometric mean of the
ratios over cars, courses and seeds is compared with a bar."""

import dataclasses
import math
import statistics

from common import DEGREES

from . import bars, courses, drives

# Roll of 8.5, 8.4, 6.2 and 3.2 ° per g; driven wheels: rear, front, rear (rear engine), rear.
CARS = {
    "bmw": ("--car", "bmw_320i"),
    "escort": ("--car", "ford_escort"),
    "vanagon": ("--car", "vw_vanagon"),
    "stiff": ("--car", "bmw_320i", "--roll-stiffness", "2.5"),
}


@dataclasses.dataclass(frozen=True)
class Drive:
    scenario: str
    speed: float  # m/s, on the straights
    duration: float  # s

    @property
    def name(self):
        return f"{self.scenario}-{self.speed:g}"

    def options(self):
        return ("--scenario", self.scenario, "--speed", f"{self.speed:g}", "--duration", f"{self.duration:g}")


DRIVES = tuple(Drive(*one) for one in (
    ("lap", 8, 120), ("lap", 15, 120), ("lap", 22, 120), ("slalom", 15, 80), ("slalom", 22, 80),
    ("stop-and-go", 15, 120), ("parking", 3, 200), ("hills", 18, 130)))
PLAIN = tuple(drive.name for drive in DRIVES if drive.scenario != "hills")  # the drives for the ratios
AT_15 = tuple(drive.name for drive in DRIVES if drive.speed == 15)
CAMERA_2D_RMS = 0.05 * math.sqrt(2)  # m

DEAD = courses.View()
MAP = courses.View(align="none")


def all_courses():
    for car, options in CARS.items():
        for drive in DRIVES:
            yield courses.Course(f"{car}-{drive.name}", (*options, *drive.options()), {})


def seed_of(course, number):
    """A seed of its own for each course, so that no two courses share their sensors' errors."""
    return 1000 * [one.name for one in all_courses()].index(course.name) + number


def measure(odom, course, seed, models, folder, scratch):
    """The drive by dead reckoning through all models, and with the camera through the last."""
    drives.simulate(odom, course, seed, folder)
    poses = {model: scratch / f"{model}.csv" for model in models}
    judged = models[-1]
    for model in models:
        drives.replay(odom, course, model, folder, poses[model])
    with_camera = dataclasses.replace(course, camera=True)
    seen = scratch / "camera.csv"
    replay = drives.replay(odom, with_camera, judged, folder, seen)
    return {"course": course.name, "seed": seed,
            "dead": drives.evaluate(odom, DEAD, folder, poses),
            "camera": drives.evaluate(odom, MAP, folder, {judged: seen})[judged],
            "innovations": replay.get("innovations", {})}


def heading_rms(evaluation):
    return evaluation["heading"]["rms"] * DEGREES


def position_rms(evaluation):
    return evaluation["position"]["rms"]


FIGURES = {"35 ms [mm]": bars.short_term_mm, "heading rms [°]": heading_rms, "position rms [m]": position_rms}
RATIO_LIMITS = {"35 ms [mm]": 0.8, "heading rms [°]": 0.3, "position rms [m]": 0.6}


class Results:
    def __init__(self, measured, judged, reference, slack=1.0):
        self.measured, self.judged, self.reference, self.slack = measured, judged, reference, slack

    def of(self, *names):
        """The drives on these courses, which are named without the car."""
        return [one for one in self.measured if one["course"].split("-", 1)[1] in names]

    def by_course(self):
        found = {}
        for one in self.measured:
            found.setdefault(one["course"], []).append(one)
        return found

    def values(self, found, figure, model=None):
        one_by_one = (one["dead"][model or self.judged] for one in found)
        return [math.inf if value is None else figure(value) for value in one_by_one]

    def seen(self, found, figure):
        return [math.inf if one["camera"] is None else figure(one["camera"]) for one in found]

    def ratios(self, found, figure):
        return [bars.ratio(value, other) for value, other in
                zip(self.values(found, figure), self.values(found, figure, self.reference))]

    within = bars.Results.within


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(max(value, 1e-9)) for value in values)) if values else math.nan


def dead_reckoning(results):
    for names, what in ((PLAIN, "all courses"), (("hills-18",), "hills")):
        found = results.of(*names)
        for name, figure in FIGURES.items() if found else ():
            ratios, limit = results.ratios(found, figure), RATIO_LIMITS[name]
            mean = geometric_mean(ratios)
            yield bars.Row(f"{what}: {name.split(' [')[0]} by {results.reference}'s, geometric mean",
                           f"≤ {limit}", f"{mean:.2f}; of a drive {bars.spread(ratios)}",
                           results.within(mean, limit))


def prediction(results):
    found = results.of(*AT_15)
    if found:
        values, other = (results.values(found, bars.short_term_mm, model)
                         for model in (None, results.reference))
        mean = geometric_mean(values)
        yield bars.Row("courses at 15 m/s: 35 ms, geometric mean", "≤ 2.5 mm",
                       f"{mean:.2f} mm; of a drive {bars.spread(values)}; {results.reference}: "
                       f"{geometric_mean(other):.2f}", results.within(mean, 2.5))


def camera(results):
    for course, found in results.by_course().items():
        values = results.seen(found, position_rms)
        limit = min(0.03, CAMERA_2D_RMS / 2)
        yield bars.Row(f"{course}: position with camera, rms", f"≤ {100 * limit:g} cm",
                       f"{100 * bars.rms(values):.2f} cm; of a drive "
                       f"{bars.spread([100 * value for value in values])}",
                       results.within(bars.rms(values), limit))


def nees(results):
    for course, found in results.by_course().items():
        values = results.seen(found, bars.nees)
        mean = statistics.fmean(values)
        yield bars.Row(f"{course}: NEES of (x, y, yaw) with camera, mean", "1.5 to 6",
                       f"{mean:.3g}; of a drive {bars.spread(values)}", results.within(mean, 6, low=1.5))


def nis(results):
    """The mean NIS of every source over the seeds of a course; the worst course counts."""
    by_source = {}
    for course, found in results.by_course().items():
        for source in dict.fromkeys(name for one in found for name in one["innovations"]):
            measured = [one["innovations"][source] for one in found if source in one["innovations"]]
            count = sum(one["count"] for one in measured)
            if count:
                mean = sum(one["count"] * one["mean_nis"] / one["dimension"] for one in measured) / count
                by_source.setdefault(source, {})[course] = mean
    if not by_source:
        yield bars.Row("NIS of every source", "0.5 to 2", f"{results.judged} has no innovations", False)
    for source, means in by_source.items():
        worst = max(means, key=lambda course: abs(math.log(max(means[course], 1e-9))))
        yield bars.Row(f"{source}: NIS by its expectation, of every course", "0.5 to 2",
                       f"{bars.spread(list(means.values()))}; furthest off: {worst}, {means[worst]:.2f}",
                       all(results.within(mean, 2, low=0.5) for mean in means.values()))


BARS = {"dead-reckoning": dead_reckoning, "prediction": prediction, "camera": camera, "nees": nees, "nis": nis}


def by_course(results):
    """The figures behind the means: medians over the seeds, without a bar."""
    yield ("| course | " + " | ".join(f"{name}: {results.judged} / {results.reference}" for name in FIGURES) +
           " | with camera [cm] |")
    yield "|---" * (len(FIGURES) + 2) + "|"
    for course, found in results.by_course().items():
        cells = [f"{statistics.median(results.values(found, figure)):.3g} / "
                 f"{statistics.median(results.values(found, figure, results.reference)):.3g}"
                 for figure in FIGURES.values()]
        seen = 100 * statistics.median(results.seen(found, position_rms))
        yield f"| {course} | " + " | ".join(cells) + f" | {seen:.2f} |"
