"""The bars that a model is held to, each a function that reads the results of its courses.

A figure is computed for every drive; its median over the seeds is compared with a bar, unless the row
names another statistic. A ratio is that of two medians."""

import dataclasses
import math
import statistics

from common import DEGREES

from . import courses

POSE_DIMENSION = 3


@dataclasses.dataclass(frozen=True)
class Row:
    what: str
    required: str
    measured: str
    met: bool


class Results:
    """The drives' results, by course; the model to judge, and those to compare with; the speeds of the laps;
    and the factor `slack` that widens the bars (for few seeds, whose medians spread more)."""

    def __init__(self, drives, judged, compared, speeds=courses.SPEEDS, slack=1.0):
        self.judged, self.compared, self.speeds, self.slack = judged, compared, speeds, slack
        self.by_course = {}
        for drive in drives:
            self.by_course.setdefault(drive["course"], []).append(drive)

    def __contains__(self, course):
        return course in self.by_course

    def drives(self, course):
        return self.by_course[course]

    def laps(self, form):
        return [f"{form}-{speed:g}" for speed in self.speeds]

    def figures(self, course, view, figure, model=None):
        """The figure for every seed; infinite where a pose was not finite."""
        found = (drive["views"][view][model or self.judged] for drive in self.by_course[course])
        return [math.inf if found_one is None else figure(found_one) for found_one in found]

    def within(self, value, limit, low=-math.inf):
        return low / self.slack <= value <= limit * self.slack


# Figures of a drive, from the output of odom evaluate.

def drift(evaluation):
    return evaluation["end_error_cm_per_m"]


def heading(evaluation):
    return abs(evaluation["heading"]["end"]) * DEGREES


def short_term_mm(evaluation):
    return 1000 * evaluation["error_35ms"]["position"]["mean"]


def position_mm(evaluation):
    return 1000 * evaluation["position"]["rms"]


def yaw_deg(evaluation):
    return evaluation["heading"]["rms"] * DEGREES


def furthest_cm(evaluation):
    return 100 * evaluation["position"]["max"]


def end_error(evaluation):
    return evaluation["end_error"]


def nees(evaluation):
    return evaluation["nees"]["mean"] if evaluation["nees"] else math.inf


# Statistics of the figures of all seeds.

def spread(values, unit=""):
    return (f"{statistics.median(values):.3g} ({min(values):.3g} to {max(values):.3g})"
            f"{' ' if unit else ''}{unit}")


def rms(values):
    return math.sqrt(statistics.fmean(value * value for value in values))


def ratio(value, other):
    return value / other if other > 0 else math.inf


def compare_with_paper(results, course, view, figure, limit, unit, what, at_most=None):
    """Requires a median of at most n/d (`limit`) of that of the paper's filter, and of at most `at_most`."""
    values = results.figures(course, view, figure)
    paper = results.figures(course, view, figure, "paper")
    median = statistics.median(values)
    times = ratio(median, statistics.median(paper))
    required = f"≤ {limit[0]}/{limit[1]} of paper's" + (f", ≤ {at_most} {unit}" if at_most else "")
    yield Row(f"{course}: {what}", required, f"{times:.2f}: {spread(values)} of {spread(paper, unit)}",
              results.within(times, limit[0] / limit[1]) and results.within(median, at_most or math.inf))


# The bars. Each function yields its rows.

def dead_reckoning(results):
    laps = results.laps("lap")
    for course in (*laps, "stop-and-go"):
        yield from compare_with_paper(results, course, "whole", drift, (1, 3), "cm/m", "drift",
                                at_most=0.4 if course in laps else None)
        yield from compare_with_paper(results, course, "whole", heading, (1, 5), "°", "heading at the end")
    yield from compare_with_paper(results, "slalom", "whole", drift, (2, 3), "cm/m", "drift")


def camera_lost(results):
    for course in results.laps("lost-15-lap"):
        values = results.figures(course, "after", drift)
        in_map = results.figures(course, "in_map", drift)
        yield Row(f"{course}: 20 m after the loss", "≤ 0.3 cm/m",
                  f"{spread(values, 'cm/m')}; not aligned there {spread(in_map)}",
                  results.within(statistics.median(values), 0.3))


def prediction(results):
    what = "35 ms after ten seconds of camera"
    for form, view in (("lost-10-lap", "after"), ("camera-lap", "odom")):
        for speed in results.speeds:
            yield from compare_with_paper(results, f"{form}-{speed:g}", view, short_term_mm, (1, 2), "mm", what,
                                    at_most=0.25 if speed == 1 else None)


def camera(results):
    for course in results.laps("camera-lap"):
        for figure, limit, unit, what in ((position_mm, 5, "mm", "position"), (yaw_deg, 0.4, "°", "yaw")):
            values = results.figures(course, "map", figure)
            yield Row(f"{course}: {what}, rms", f"≤ {limit} {unit}",
                      f"{rms(values):.3g} {unit}; of a drive {spread(values)}",
                      results.within(rms(values), limit))


def outliers(results):
    for speed in results.speeds:
        for figure, what in ((position_mm, "position"), (yaw_deg, "yaw")):
            without = results.figures(f"camera-lap-{speed:g}", "map", figure)
            values = results.figures(f"outliers-lap-{speed:g}", "map", figure)
            change = 100 * (ratio(rms(values), rms(without)) - 1)
            of_seeds = [100 * (ratio(a, b) - 1) for a, b in zip(values, without)]
            yield Row(f"outliers-lap-{speed:g}: {what}, rms, compared with none", "< 10 % more",
                      f"{change:+.1f} %; of a drive {spread(of_seeds)}", results.within(change, 10))


def gap(results):
    values = [value for begin, _ in courses.GAPS
              for value in results.figures("gaps-lap", f"gap-{begin}", furthest_cm)]
    yield Row("gaps-lap: furthest off in 2 s without camera at 1.5 m/s", "< 3 cm", spread(values, "cm"),
              results.within(max(values), 3))


def no_worse(results):
    for course in MANOEUVRES:
        view = "map" if course.startswith("camera") else "whole"
        values = [100 * value for value in results.figures(course, view, end_error)]
        best = [100 * min(both) for both in zip(*(results.figures(course, view, end_error, model)
                                                   for model in results.compared))]
        worse = sum(not results.within(value, 1.1 * other + 1) for value, other in zip(values, best))
        yield Row(f"{course}: end error, every seed", "≤ 1.1 × the better of kinematic, paper + 1 cm",
                  f"{worse} of {len(values)} seeds worse; {spread(values)} against {spread(best, 'cm')}",
                  worse == 0)


def finite(results):
    broken = {drive["course"] for course in results.by_course.values() for drive in course
              if any(view[results.judged] is None for view in drive["views"].values())}
    count = sum(len(course) for course in results.by_course.values())
    yield Row("poses that are not finite, in all drives", "none",
              ", ".join(sorted(broken)) or f"none in {count} drives", not broken)


def nees_of_laps(results):
    for course in results.laps("camera-lap"):
        values = results.figures(course, "map", nees)
        mean = statistics.fmean(values)
        yield Row(f"{course}: NEES of (x, y, yaw), mean", f"{POSE_DIMENSION / 2} to {2 * POSE_DIMENSION}",
                  f"{mean:.3g}; of a drive {spread(values)}",
                  results.within(mean, 2 * POSE_DIMENSION, low=POSE_DIMENSION / 2))


def nis_of_laps(results):
    reports = [drive["replay"][results.judged].get("innovations", {})
               for course in results.laps("camera-lap") for drive in results.drives(course)]
    sources = list(dict.fromkeys(source for report in reports for source in report))
    if not sources:
        yield Row("camera-lap: NIS of every source", "0.5 to 2 of expectation",
                  f"odom replay reports no innovations of {results.judged}", False)
    for source in sources:
        yield from innovations(results, source, [report[source] for report in reports if source in report])


def innovations(results, source, measured):
    """Over all samples of all drives: NIS divided by its expectation, the dimension of the measurement."""
    measured = [one for one in measured if one["count"] > 0]
    count = sum(one["count"] for one in measured)
    if count:
        nis = sum(one["count"] * one["mean_nis"] / one["dimension"] for one in measured) / count
        inside = 100 * sum(one["count"] * one["inside_95"] for one in measured) / count
        yield Row(f"camera-lap: {source}, mean NIS by its expectation; inside χ²₉₅",
                  "0.5 to 2; 90 to 99 %", f"{nis:.2f}; {inside:.1f} % of {count}",
                  results.within(nis, 2, low=0.5) and 90 <= inside <= 99)


def shift(results):
    for course in results.laps("camera-lap"):
        measured = [drive["shift"] for drive in results.drives(course)]
        values = [1e6 * one["largest"] for one in measured]
        crossed = statistics.median(one["crossed"] for one in measured)
        yield Row(f"{course}: all stamps 1 µs later, largest change of a pose", "≤ 10 µm",
                  f"{spread(values, 'µm')}; without {crossed:g} ticks a drive that lack a frame by it",
                  results.within(max(values), 10))


def standing(results):
    """The effect of a gyro that is quieter at rest than on the move."""
    for speed in results.speeds:
        course = f"shaken-lap-{speed:g}"
        for figure, limit, unit, what in ((heading, 1, "°", "heading at the end of a minute"),
                                          (drift, 0.25, "cm/m", "drift")):
            values = results.figures(course, "whole", figure)
            yield Row(f"{course}: {what}", f"≤ {limit} {unit}", spread(values, unit),
                      results.within(statistics.median(values), limit))


def close(results):
    """The error of the filter with the camera, and afterwards without it."""
    for speed, at_most, ahead in ((1.0, 3, 0.12), (2.0, 4, 0.35)):
        if speed not in results.speeds:
            continue
        course = f"camera-lap-{speed:g}"
        values = results.figures(course, "map", position_mm)
        yield Row(f"{course}: position, rms", f"≤ {at_most} mm",
                  f"{rms(values):.3g} mm; of a drive {spread(values)}", results.within(rms(values), at_most))
        values = results.figures(course, "odom", short_term_mm)
        yield Row(f"{course}: 35 ms after ten seconds of camera", f"≤ {ahead} mm", spread(values, "mm"),
                  results.within(statistics.median(values), ahead))
    for speed in results.speeds:
        if speed <= 2.0:
            course = f"lost-15-lap-{speed:g}"
            values = results.figures(course, "after", drift)
            yield Row(f"{course}: 20 m after the loss", "≤ 0.2 cm/m", spread(values, "cm/m"),
                      results.within(statistics.median(values), 0.2))


MANOEUVRES = (*courses.MANOEUVRES, *(f"camera-{name}" for name in courses.MANOEUVRES))
BARS = {  # name: (function, prefixes of the courses that it reads)
    "dead-reckoning": (dead_reckoning, ("lap-", "stop-and-go", "slalom")),
    "camera-lost": (camera_lost, ("lost-15-",)),
    "prediction": (prediction, ("lost-10-", "camera-lap-")),
    "camera": (camera, ("camera-lap-",)),
    "outliers": (outliers, ("camera-lap-", "outliers-")),
    "gap": (gap, ("gaps-",)),
    "no-worse": (no_worse, MANOEUVRES),
    "nees": (nees_of_laps, ("camera-lap-",)),
    "nis": (nis_of_laps, ("camera-lap-",)),
    "shift": (shift, ("camera-lap-",)),
    "finite": (finite, MANOEUVRES),
    "standing": (standing, ("shaken-",)),
    "close": (close, ("camera-lap-", "lost-15-")),
}


def courses_of(names, speeds):
    """The courses that the bars of these names read."""
    wanted = tuple(begin for name in names for begin in BARS[name][1])
    return [course for course in courses.all_courses(speeds) if course.name.startswith(wanted)]
