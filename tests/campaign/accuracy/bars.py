"""The bars that a model is held to, each a function that reads the results of its courses.

A figure is computed for every drive; its median over the seeds is compared with a bar, unless the row
names another statistic. A ratio is that of two medians."""

import math
import statistics
from collections.abc import Callable
from typing import Any, NamedTuple

from common import DEGREES, Row

from . import courses
from .courses import all_courses  # noqa: F401

COMPARED = ("kinematic", "paper")


class Figure(NamedTuple):
    unit: str
    of: Callable[[dict[str, Any]], float]  # from the output of odom evaluate


DRIFT = Figure("cm/m", lambda e: e["end_error_cm_per_m"])
HEADING = Figure("°", lambda e: abs(e["heading"]["end"]) * DEGREES)
AHEAD = Figure("mm", lambda e: 1000 * e["error_35ms"]["position"]["mean"])
POSITION = Figure("mm", lambda e: 1000 * e["position"]["rms"])
YAW = Figure("°", lambda e: e["heading"]["rms"] * DEGREES)
FURTHEST = Figure("cm", lambda e: 100 * e["position"]["max"])
END = Figure("cm", lambda e: 100 * e["end_error"])
NEES = Figure("", lambda e: e["nees"]["mean"] if e["nees"] else math.inf)


class Results:
    """The drives' results, by course; the model to judge; the speeds of the laps; and the factor `slack` that
    widens the bars (for few seeds, whose medians spread more)."""

    def __init__(self, drives, given):
        self.judged, self.speeds, self.slack = given.model, given.speed, given.slack
        self.by_course = {}
        for drive in drives:
            self.by_course.setdefault(drive["course"], []).append(drive)

    def laps(self, form):
        return [f"{form}-{speed:g}" for speed in self.speeds]

    def figures(self, course, view, figure, model=None):
        """The figure for every seed."""
        return self.of_drives(self.by_course[course], view, figure, model)

    def of_drives(self, drives, view, figure, model=None):
        """The figure for each of these drives; infinite where a pose was not finite."""
        found = (drive["views"][view][model or self.judged] for drive in drives)
        return [math.inf if one is None else figure.of(one) for one in found]

    def innovations(self, drives):
        """The sources whose innovations the drives' replays report, each with its reports."""
        by_source = {}
        for drive in drives:
            for source, report in drive["replay"][self.judged].get("innovations", {}).items():
                by_source.setdefault(source, []).append(report)
        return by_source

    def within(self, value, limit, low=-math.inf):
        return low / self.slack <= value <= limit * self.slack

    def row(self, what, required, measured, value, limit, low=-math.inf):
        return Row(what, required, measured, self.within(value, limit, low))


# Statistics of the figures of all seeds.

def spread(values, unit=""):
    return (f"{statistics.median(values):.3g} ({min(values):.3g} to {max(values):.3g})"
            f"{' ' if unit else ''}{unit}")


def rms(values):
    return math.sqrt(statistics.fmean(value * value for value in values))


def ratio(value, other):
    return value / other if other > 0 else math.inf


def mean_nis(measured):
    """The number of samples, and their mean NIS divided by its expectation, the dimension of the measurement."""
    count = sum(one["count"] for one in measured)
    return count, sum(one["count"] * one["mean_nis"] / one["dimension"] for one in measured) / max(count, 1)


# The bars. Each is a function that yields its rows.

class Limit(NamedTuple):
    """A limit for a statistic, median or rms, of a figure's values on laps."""

    form: str
    view: str
    figure: Figure
    what: str
    limits: dict[float, float]  # by speed
    statistic: Callable[[list[float]], float] = statistics.median

    def row(self, results, speed):
        unit, limit = self.figure.unit, self.limits[speed]
        values = results.figures(f"{self.form}-{speed:g}", self.view, self.figure)
        shown = (f"{rms(values):.3g} {unit}; of a drive {spread(values)}" if self.statistic is rms
                 else spread(values, unit))
        return results.row(f"{self.form}-{speed:g}: {self.what}", f"≤ {limit} {unit}", shown, self.statistic(values), limit)


def laps_within(*limits):
    """A bar of limits."""
    return lambda results: (one.row(results, speed) for speed in results.speeds for one in limits if speed in one.limits)


def at_all_speeds(limit):
    return dict.fromkeys(courses.SPEEDS, limit)


def at_most_of_paper(results, course, view, figure, limit, what, at_most=None):
    """Requires a median of at most n/d (`limit`) of that of the paper's filter, and of at most `at_most`."""
    values = results.figures(course, view, figure)
    paper = results.figures(course, view, figure, "paper")
    median = statistics.median(values)
    times = ratio(median, statistics.median(paper))
    required = f"≤ {limit[0]}/{limit[1]} of paper's" + (f", ≤ {at_most} {figure.unit}" if at_most else "")
    return Row(f"{course}: {what}", required, f"{times:.2f}: {spread(values)} of {spread(paper, figure.unit)}",
               results.within(times, limit[0] / limit[1]) and results.within(median, at_most or math.inf))


def dead_reckoning(results):
    laps = results.laps("lap")
    for course in (*laps, "stop-and-go"):
        yield at_most_of_paper(results, course, "whole", DRIFT, (1, 3), "drift", at_most=0.4 if course in laps else None)
        yield at_most_of_paper(results, course, "whole", HEADING, (1, 5), "heading at the end")
    yield at_most_of_paper(results, "slalom", "whole", DRIFT, (2, 3), "drift")


def prediction(results):
    for form, view in (("lost-10-lap", "after"), ("camera-lap", "odom")):
        for speed in results.speeds:
            yield at_most_of_paper(results, f"{form}-{speed:g}", view, AHEAD, (1, 2),
                                   "35 ms after ten seconds of camera", at_most=0.25 if speed == 1 else None)


def outliers(results):
    for speed in results.speeds:
        for figure, what in ((POSITION, "position"), (YAW, "yaw")):
            without = results.figures(f"camera-lap-{speed:g}", "map", figure)
            values = results.figures(f"outliers-lap-{speed:g}", "map", figure)
            change = 100 * (ratio(rms(values), rms(without)) - 1)
            of_seeds = [100 * (ratio(a, b) - 1) for a, b in zip(values, without)]
            yield results.row(f"outliers-lap-{speed:g}: {what}, rms, compared with none", "< 10 % more",
                              f"{change:+.1f} %; of a drive {spread(of_seeds)}", change, 10)


def gap(results):
    values = [value for begin, _ in courses.GAPS
              for value in results.figures("gaps-lap", f"gap-{begin}", FURTHEST)]
    yield results.row("gaps-lap: furthest off in 2 s without camera at 1.5 m/s", "< 3 cm", spread(values, "cm"),
                      max(values), 3)


def no_worse(results):
    for course in MANOEUVRES:
        view = "map" if course.startswith("camera") else "whole"
        values = results.figures(course, view, END)
        best = [min(both) for both in zip(*(results.figures(course, view, END, model) for model in COMPARED))]
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


def nees_row(results, what, values):
    mean = statistics.fmean(values)
    return results.row(f"{what}, mean", "1.5 to 6", f"{mean:.3g}; of a drive {spread(values)}", mean, 6, low=1.5)


def nees_of_laps(results):
    for course in results.laps("camera-lap"):
        yield nees_row(results, f"{course}: NEES of (x, y, yaw)", results.figures(course, "map", NEES))


def nis_of_laps(results):
    """Over all samples of all drives."""
    by_source = results.innovations(drive for course in results.laps("camera-lap")
                                    for drive in results.by_course[course])
    if not by_source:
        yield Row("camera-lap: NIS of every source", "0.5 to 2 of expectation",
                  f"odom replay reports no innovations of {results.judged}", False)
    for source, reports in by_source.items():
        measured = [report for report in reports if report["count"] > 0]
        count, nis = mean_nis(measured)
        if count:
            inside = 100 * sum(one["count"] * one["inside_95"] for one in measured) / count
            yield Row(f"camera-lap: {source}, mean NIS by its expectation; inside χ²₉₅",
                      "0.5 to 2; 90 to 99 %", f"{nis:.2f}; {inside:.1f} % of {count}",
                      results.within(nis, 2, low=0.5) and 90 <= inside <= 99)


def shift(results):
    for course in results.laps("camera-lap"):
        measured = [drive["shift"] for drive in results.by_course[course]]
        values = [1e6 * one["largest"] for one in measured]
        crossed = statistics.median(one["crossed"] for one in measured)
        yield results.row(f"{course}: all stamps 1 µs later, largest change of a pose", "≤ 10 µm",
                          f"{spread(values, 'µm')}; without {crossed:g} ticks a drive that lack a frame by it",
                          max(values), 10)


camera = laps_within(Limit("camera-lap", "map", POSITION, "position, rms", at_all_speeds(5), rms),
                     Limit("camera-lap", "map", YAW, "yaw, rms", at_all_speeds(0.4), rms))
# The effect of a gyro that is quieter at rest than on the move.
standing = laps_within(Limit("shaken-lap", "whole", HEADING, "heading at the end of a minute", at_all_speeds(1)),
                       Limit("shaken-lap", "whole", DRIFT, "drift", at_all_speeds(0.25)))
camera_lost = laps_within(Limit("lost-15-lap", "after", DRIFT, "20 m after the loss", at_all_speeds(0.3)))
# The error of the filter with the camera, and afterwards without it.
close = laps_within(
    Limit("camera-lap", "map", POSITION, "position, rms", {1.0: 3, 2.0: 4}, rms),
    Limit("camera-lap", "odom", AHEAD, "35 ms after ten seconds of camera", {1.0: 0.12, 2.0: 0.35}),
    Limit("lost-15-lap", "after", DRIFT, "20 m after the loss", {1.0: 0.2, 1.5: 0.2, 2.0: 0.2}))

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
