"""Charts as SVG: one dot per drive, a bar for the median, on a logarithmic axis, courses side by side."""

import dataclasses
import math
import statistics
from xml.sax.saxutils import escape

from . import bars, courses

COLOURS = {"kinematic": "#b8b8b8", "paper": "#e08a3c"}
JUDGED = "#1f6fb4"
HEIGHT, TOP, BOTTOM, LEFT = 300, 46, 64, 56
MODEL_WIDTH, COURSE_GAP = 26, 22


@dataclasses.dataclass(frozen=True)
class Chart:
    file: str
    title: str
    figure: bars.Figure
    places: tuple  # (course, view)
    limit: float | None = None  # largest value allowed on laps


def laps(form, view):
    return tuple((f"{form}lap-{speed:g}", view) for speed in courses.SPEEDS)


WITHOUT = (*laps("", "whole"), *((name, "whole") for name in courses.MANOEUVRES))
WITH = (*laps("camera-", "map"), *((f"camera-{name}", "map") for name in courses.MANOEUVRES))
CHARTS = (
    Chart("drift", "Without camera: end error [cm/m]", bars.DRIFT, WITHOUT, 0.4),
    Chart("heading", "Without camera: heading at the end [°]", bars.HEADING, WITHOUT),
    Chart("lost", "20 m after the camera's loss: end error [cm/m]", bars.DRIFT,
          laps("lost-15-", "after"), 0.3),
    Chart("prediction", "35 ms, after ten seconds of camera: mean [mm]", bars.AHEAD,
          (*laps("lost-10-", "after"), *laps("camera-", "odom")), 0.25),
    Chart("position", "With camera: position, rms [mm]", bars.POSITION,
          (*WITH, *laps("outliers-", "map")), 5),
    Chart("yaw", "With camera: yaw, rms [°]", bars.YAW, (*WITH, *laps("outliers-", "map")), 0.4),
    Chart("gap", "2 s without camera at 1.5 m/s: furthest off [cm]", bars.FURTHEST,
          tuple(("gaps-lap", f"gap-{begin}") for begin, _ in courses.GAPS), 3),
    Chart("nees", "With camera: NEES of (x, y, yaw), honest: 3", bars.NEES, WITH, 3),
)


class Axis:
    """Logarithmic, from bottom to top, over the values that are finite and not zero."""

    def __init__(self, values):
        shown = [value for value in values if 0 < value < math.inf] or [1.0]
        self.low, self.high = math.log10(min(shown)) - 0.1, math.log10(max(shown)) + 0.1

    def y(self, value):
        share = (math.log10(value) - self.low) / (self.high - self.low) if value > 0 else 0.0
        return HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * min(1.0, max(0.0, share))

    def ticks(self):
        for decade in range(math.floor(self.low), math.ceil(self.high) + 1):
            for digit in (1, 2, 5):
                if self.low <= math.log10(digit) + decade <= self.high:
                    yield digit * 10.0**decade


def text(x, y, words, anchor="middle", size=11):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}">{escape(words)}</text>'


def line(x1, y1, x2, y2, style):
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" {style}/>'


def legend(models):
    for index, (model, colour) in enumerate(models.items()):
        x = LEFT + 110 * index
        yield f'<circle cx="{x}" cy="33" r="4" fill="{colour}"/>' + text(x + 9, 37, model, "start")


def strip(axis, x, values, colour):
    """The drives of one model on one course, around x."""
    for index, value in enumerate(values):
        across = x + (MODEL_WIDTH - 8) * ((index + 0.5) / len(values) - 0.5)
        yield (f'<circle cx="{across:.1f}" cy="{axis.y(value):.1f}" r="2.2" fill="{colour}" '
               'fill-opacity="0.55"/>')
    y = axis.y(statistics.median(values))
    yield line(x - 10, y, x + 10, y, f'stroke="{colour}" stroke-width="3"')


def draw(chart, results):
    """The chart's SVG; nothing if none of its courses was driven."""
    places = [(course, view) for course, view in chart.places if course in results]
    models = {model: COLOURS.get(model, JUDGED) for model in dict.fromkeys([*results.compared, results.judged])}
    figures = {(*place, model): results.figures(*place, chart.figure, model)
               for place in places for model in models}
    if not figures:
        return None
    course_width = MODEL_WIDTH * len(models) + COURSE_GAP
    width = LEFT + course_width * len(places) + 10
    axis = Axis([value for values in figures.values() for value in values] + [chart.limit or 0.0])
    marks = [text(LEFT, 18, chart.title, "start", 14), *legend(models)]
    for tick in axis.ticks():
        marks.append(line(LEFT, axis.y(tick), width - 10, axis.y(tick), 'stroke="#e4e4e4"'))
        marks.append(text(LEFT - 6, axis.y(tick) + 4, f"{tick:g}", "end"))
    for index, (course, view) in enumerate(places):
        begin = LEFT + course_width * index + COURSE_GAP / 2
        for number, (model, colour) in enumerate(models.items()):
            x = begin + MODEL_WIDTH * (number + 0.5)
            marks.extend(strip(axis, x, figures[course, view, model], colour))
        if chart.limit and "lap" in course:
            y = axis.y(chart.limit)
            dashed = 'stroke="#c03030" stroke-dasharray="5 4"'
            marks.append(line(begin, y, begin + MODEL_WIDTH * len(models), y, dashed))
        name = f"{view} s" if view.startswith("gap-") else course
        # Labels alternate between two lines, so that neighbours do not overlap.
        below = HEIGHT - BOTTOM + 18 + 16 * (index % 2)
        marks.append(text(begin + MODEL_WIDTH * len(models) / 2, below, name))
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{HEIGHT}" '
            f'viewBox="0 0 {width} {HEIGHT}" font-family="sans-serif">\n'
            f'<rect width="100%" height="100%" fill="white"/>\n' + "\n".join(marks) + "\n</svg>\n")


def write(results, folder):
    for chart in CHARTS:
        svg = draw(chart, results)
        if svg:
            (folder / f"{chart.file}.svg").write_text(svg)
