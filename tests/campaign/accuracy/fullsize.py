"""The full-size cars of odom sim: what they drive, and the bars that a model is held to there.

A ratio divides a drive's figure for the model by that for the reference model; the geometric mean of the
ratios over cars, courses and seeds is compared with a bar."""

import dataclasses
import math
import statistics

from common import Row, geometric_mean

from . import bars, courses

# Roll of 8.5, 8.4, 6.2 and 3.2 ° per g; driven wheels: rear, front, rear (rear engine), rear.
CARS = {
    "bmw": ("--car", "bmw_320i"),
    "escort": ("--car", "ford_escort"),
    "vanagon": ("--car", "vw_vanagon"),
    "stiff": ("--car", "bmw_320i", "--roll-stiffness", "2.5"),
}

# Scenario, speed on the straights [m/s], duration [s].
DRIVES = {f"{scenario}-{speed}": ("--scenario", scenario, "--speed", speed, "--duration", duration)
          for scenario, speed, duration in (
              ("lap", 8, 120), ("lap", 15, 120), ("lap", 22, 120), ("slalom", 15, 80), ("slalom", 22, 80),
              ("stop-and-go", 15, 120), ("parking", 3, 200), ("hills", 18, 130))}
COMPARED = ("inertial",)
REFERENCE = COMPARED[0]
PLAIN = tuple(name for name in DRIVES if name != "hills-18")  # the drives for the ratios
AT_15 = tuple(name for name in DRIVES if name.endswith("-15"))

VIEWS = {"dead": courses.View(), "map": dataclasses.replace(courses.MAP, compared=False)}


def all_courses(_speeds=()):
    """Each with seeds of its own, so that no two courses share their sensors' errors."""
    every = [(f"{car}-{name}", (*options, *drive)) for car, options in CARS.items() for name, drive in DRIVES.items()]
    for i, (name, options) in enumerate(every):
        yield courses.Course(name, options, VIEWS, seeds_after=1000 * i)


FIGURES = {"35 ms [mm]": bars.AHEAD, "heading rms [°]": bars.YAW,
           "position rms [m]": bars.Figure("m", lambda e: e["position"]["rms"])}
RATIO_LIMITS = {"35 ms [mm]": 0.8, "heading rms [°]": 0.3, "position rms [m]": 0.6}
SEEN_CM = bars.Figure("cm", lambda e: 100 * e["position"]["rms"])


class Results(bars.Results):
    def of(self, *names):
        """The drives on these courses, which are named without the car."""
        return [one for found in self.by_course.values() for one in found if one["course"].split("-", 1)[1] in names]

    def values(self, found, figure, model=None):
        return self.of_drives(found, "dead", figure, model)

    def seen(self, course, figure):
        return self.figures(course, "map", figure)

    def ratios(self, found, figure):
        return list(map(bars.ratio, self.values(found, figure), self.values(found, figure, REFERENCE)))


def dead_reckoning(results):
    for names, what in ((PLAIN, "all courses"), (("hills-18",), "hills")):
        found = results.of(*names)
        for name, figure in FIGURES.items():
            ratios, limit = results.ratios(found, figure), RATIO_LIMITS[name]
            mean = geometric_mean(ratios)
            yield results.row(f"{what}: {name.split(' [')[0]} by {REFERENCE}'s, geometric mean",
                              f"≤ {limit}", f"{mean:.2f}; of a drive {bars.spread(ratios)}", mean, limit)


def prediction(results):
    found = results.of(*AT_15)
    values, other = (results.values(found, bars.AHEAD, model) for model in (None, REFERENCE))
    mean = geometric_mean(values)
    yield results.row("courses at 15 m/s: 35 ms, geometric mean", "≤ 2.5 mm",
                      f"{mean:.2f} mm; of a drive {bars.spread(values)}; {REFERENCE}: {geometric_mean(other):.2f}",
                      mean, 2.5)


def camera(results):
    for course in results.by_course:
        values = results.seen(course, SEEN_CM)
        yield results.row(f"{course}: position with camera, rms", "≤ 3 cm",
                          f"{bars.rms(values):.2f} cm; of a drive {bars.spread(values)}", bars.rms(values), 3)


def nees(results):
    for course in results.by_course:
        yield bars.nees_row(results, f"{course}: NEES of (x, y, yaw) with camera", results.seen(course, bars.NEES))


def nis(results):
    """The mean NIS of every source over the seeds of a course; the worst course counts."""
    by_source = {}
    for course, found in results.by_course.items():
        for source, reports in results.innovations(found).items():
            count, mean = bars.mean_nis(reports)
            if count:
                by_source.setdefault(source, {})[course] = mean
    if not by_source:
        yield Row("NIS of every source", "0.5 to 2", f"{results.judged} has no innovations", False)
    for source, means in by_source.items():
        worst = max(means, key=lambda course: abs(math.log(max(means[course], 1e-9))))
        yield Row(f"{source}: NIS by its expectation, of every course", "0.5 to 2",
                  f"{bars.spread(list(means.values()))}; furthest off: {worst}, {means[worst]:.2f}",
                  all(results.within(mean, 2, low=0.5) for mean in means.values()))


EVERY = ("",)
BARS = {"dead-reckoning": (dead_reckoning, EVERY), "prediction": (prediction, EVERY), "camera": (camera, EVERY),
        "nees": (nees, EVERY), "nis": (nis, EVERY)}


def further(results):
    """The figures behind the means: medians over the seeds, without a bar."""
    yield ("| course | " + " | ".join(f"{name}: {results.judged} / {REFERENCE}" for name in FIGURES) +
           " | with camera [cm] |")
    yield "|---" * (len(FIGURES) + 2) + "|"
    for course, found in results.by_course.items():
        cells = [f"{statistics.median(results.values(found, figure)):.3g} / "
                 f"{statistics.median(results.values(found, figure, REFERENCE)):.3g}"
                 for figure in FIGURES.values()]
        seen = statistics.median(results.seen(course, SEEN_CM))
        yield f"| {course} | " + " | ".join(cells) + f" | {seen:.2f} |"
