"""The bars that a model is held to, each a function that reads the results of its courses.

A figure is taken of every drive; what is held against a bar is its median over the seeds, or what the
row names. Ratios are those of two medians."""

import dataclasses
import math
import statistics

from . import courses

DEGREES = 180 / math.pi
POSE_DIMENSION = 3


@dataclasses.dataclass(frozen=True)
class Row:
    what: str
    required: str
    measured: str
    met: bool | None  # None: for information


class Results:
    """What the drives gave, by course, and the models in question."""

    def __init__(self, drives, judged, beside):
        self.judged, self.beside = judged, beside
        self.by_course = {}
        for drive in drives:
            self.by_course.setdefault(drive["course"], []).append(drive)

    def __contains__(self, course):
        return course in self.by_course

    def drives(self, course):
        return self.by_course[course]

    def figures(self, course, view, figure, model=None):
        """Of every seed; infinite where a pose was not finite."""
        found = (drive["views"][view][model or self.judged] for drive in self.by_course[course])
        return [math.inf if found_one is None else figure(found_one) for found_one in found]


# Figures of a drive, from what odom evaluate says.

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


# What is made of the figures of all seeds.

def spread(values, unit=""):
    return (f"{statistics.median(values):.3g} ({min(values):.3g} to {max(values):.3g})"
            f"{' ' if unit else ''}{unit}")


def rms(values):
    return math.sqrt(statistics.fmean(value * value for value in values))


def ratio(value, other):
    return value / other if other > 0 else math.inf


def median_at_most(results, course, view, figure, limit, unit, what):
    values = results.figures(course, view, figure)
    yield Row(f"{course}: {what}", f"≤ {limit} {unit}", spread(values, unit), statistics.median(values) <= limit)


def median_beside_paper(results, course, view, figure, limit, unit, what):
    """`limit` is a fraction (n, d) of the paper's."""
    values = results.figures(course, view, figure)
    paper = results.figures(course, view, figure, "paper")
    times = ratio(statistics.median(values), statistics.median(paper))
    yield Row(f"{course}: {what}", f"≤ {limit[0]}/{limit[1]} of paper's",
              f"{times:.2f}: {spread(values)} of {spread(paper, unit)}", times <= limit[0] / limit[1])


# The bars. Each yields rows; `needs` are the courses that it reads.

def dead_reckoning(results):
    laps = [f"lap-{speed:g}" for speed in courses.SPEEDS]
    for course in (*laps, "stop-and-go"):
        yield from median_beside_paper(results, course, "whole", drift, (1, 3), "cm/m", "drift")
        yield from median_beside_paper(results, course, "whole", heading, (1, 5), "°", "heading at the end")
    yield from median_beside_paper(results, "slalom", "whole", drift, (2, 3), "cm/m", "drift")
    for course in laps:
        yield from median_at_most(results, course, "whole", drift, 0.4, "cm/m", "drift")


def camera_lost(results):
    for speed in courses.SPEEDS:
        course = f"lost-15-lap-{speed:g}"
        yield from median_at_most(results, course, "after", drift, 0.3, "cm/m", "20 m after the loss")
        in_map = results.figures(course, "in_map", drift)
        yield Row(f"{course}: the same with the error at the loss", "", spread(in_map, "cm/m"), None)


def prediction(results):
    for form, view in (("lost-10-lap", "after"), ("camera-lap", "odom")):
        for speed in courses.SPEEDS:
            what = "35 ms after ten seconds of camera"
            yield from median_beside_paper(results, f"{form}-{speed:g}", view, short_term_mm, (1, 2), "mm", what)
        yield from median_at_most(results, f"{form}-1", view, short_term_mm, 0.25, "mm", what)


def camera(results):
    for speed in courses.SPEEDS:
        course = f"camera-lap-{speed:g}"
        for figure, limit, unit, what in ((position_mm, 5, "mm", "position"), (yaw_deg, 0.4, "°", "yaw")):
            values = results.figures(course, "map", figure)
            yield Row(f"{course}: {what}, rms", f"≤ {limit} {unit}",
                      f"{rms(values):.3g} {unit}; of a drive {spread(values)}", rms(values) <= limit)


def outliers(results):
    for speed in courses.SPEEDS:
        for figure, what in ((position_mm, "position"), (yaw_deg, "yaw")):
            without = results.figures(f"camera-lap-{speed:g}", "map", figure)
            values = results.figures(f"outliers-lap-{speed:g}", "map", figure)
            change = 100 * (ratio(rms(values), rms(without)) - 1)
            of_seeds = [100 * (ratio(a, b) - 1) for a, b in zip(values, without)]
            yield Row(f"outliers-lap-{speed:g}: {what}, rms, beside none", "< 10 % more",
                      f"{change:+.1f} %; of a drive {spread(of_seeds)}", change < 10)


def gap(results):
    values = [value for begin, _ in courses.GAPS
              for value in results.figures("gaps-lap", f"gap-{begin}", furthest_cm)]
    yield Row("gaps-lap: furthest off in 2 s without camera at 1.5 m/s", "< 3 cm",
              f"{spread(values, 'cm')}; 95 % of the gaps within {percentile(values, 95):.3g} cm",
              statistics.median(values) < 3)


def percentile(values, percent):
    return sorted(values)[min(len(values) - 1, math.ceil(len(values) * percent / 100) - 1)]


def no_worse(results):
    for course in (*courses.MANOEUVRES, *(f"camera-{name}" for name in courses.MANOEUVRES)):
        view = "map" if course.startswith("camera") else "whole"
        values = results.figures(course, view, end_error)
        best = [min(both) for both in zip(*(results.figures(course, view, end_error, model)
                                             for model in results.beside))]
        excess = [100 * (value - (1.1 * other + 0.01)) for value, other in zip(values, best)]
        worse = sum(value > 0 for value in excess)
        yield Row(f"{course}: end error, no seed worse", "≤ 1.1 × the better of kinematic, paper + 1 cm",
                  f"{worse} of {len(excess)} seeds worse, by {max(0, max(excess)):.3g} cm; "
                  f"{spread([100 * value for value in values])} beside {spread([100 * b for b in best], 'cm')}",
                  worse == 0)
    broken = [drive["course"] for course in results.by_course.values() for drive in course
              if any(view[results.judged] is None for view in drive["views"].values())]
    yield Row("all drives: poses that are not finite", "none",
              f"{len(broken)} drives{': ' if broken else ''}{', '.join(sorted(set(broken)))}", not broken)


def consistency(results):
    for speed in courses.SPEEDS:
        values = results.figures(f"camera-lap-{speed:g}", "map", nees)
        mean = statistics.fmean(values)
        yield Row(f"camera-lap-{speed:g}: NEES of (x, y, yaw), mean", f"{POSE_DIMENSION / 2} to {2 * POSE_DIMENSION}",
                  f"{mean:.3g}; of a drive {spread(values)}", POSE_DIMENSION / 2 <= mean <= 2 * POSE_DIMENSION)
    reports = [drive["replay"][results.judged].get("innovations", {})
               for speed in courses.SPEEDS for drive in results.drives(f"camera-lap-{speed:g}")]
    sources = sorted({source for report in reports for source in report})
    if not sources:
        yield Row("camera-lap: NIS of every source", "0.5 to 2 of expectation",
                  f"odom replay tells no innovations of {results.judged}", False)
    for source in sources:
        yield innovations_row(source, [report[source] for report in reports if source in report])


def innovations_row(source, told):
    """Means over all samples of all drives; a mean NIS of a source is in units of its dimension."""
    told = [one for one in told if one["count"] > 0]
    count = sum(one["count"] for one in told)
    if not count:
        return Row(f"camera-lap: NIS of {source}", "0.5 to 2 of expectation", "no sample", False)
    nis = sum(one["count"] * one["mean_nis"] / one["dimension"] for one in told) / count
    inside = 100 * sum(one["count"] * one["inside_95"] for one in told) / count
    return Row(f"camera-lap: NIS of {source}, mean by its expectation; inside χ²₉₅", "0.5 to 2; 90 to 99 %",
               f"{nis:.2f}; {inside:.1f} %", 0.5 <= nis <= 2 and 90 <= inside <= 99)


def shift(results):
    for speed in courses.SPEEDS:
        told = [drive["shift"] for drive in results.drives(f"camera-lap-{speed:g}")]
        values = [1e6 * one["largest"] for one in told]
        yield Row(f"camera-lap-{speed:g}: all stamps 1 µs later, largest change of a pose", "≤ 10 µm",
                  f"{max(values):.3g} µm; of a drive {spread(values)}; left out: "
                  f"{statistics.median(one['crossed'] for one in told):g} ticks a drive that know less by it",
                  max(values) <= 10)


BARS = {
    "dead-reckoning": (dead_reckoning, ("lap-", "stop-and-go", "slalom")),
    "camera-lost": (camera_lost, ("lost-15-",)),
    "prediction": (prediction, ("lost-10-", "camera-lap-")),
    "camera": (camera, ("camera-lap-",)),
    "outliers": (outliers, ("camera-lap-", "outliers-")),
    "gap": (gap, ("gaps-",)),
    "no-worse": (no_worse, (*courses.MANOEUVRES, *(f"camera-{name}" for name in courses.MANOEUVRES))),
    "consistency": (consistency, ("camera-lap-",)),
    "shift": (shift, ("camera-lap-",)),
}


def courses_of(names):
    """The courses that the bars of these names read."""
    wanted = tuple(begin for name in names for begin in BARS[name][1])
    return [course for course in courses.all_courses() if course.name.startswith(wanted)]
