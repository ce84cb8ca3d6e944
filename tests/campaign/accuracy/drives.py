"""Replays a simulated drive through the models and evaluates what comes out."""

import csv
import math

from common import Failed, evaluate, replay

SHIFT_NS = 1000  # added to all stamps
PERIOD_NS = 5_000_000  # period of the tick grid


def seconds_to_metres(truth, begin, metres):
    """Time after the start of the drive [s] at which the car has driven this many metres since `begin`."""
    first = before = None
    driven = 0.0
    with open(truth, newline="") as file:
        for row in csv.DictReader(file):
            t, x, y = float(row["t"]), float(row["x"]), float(row["y"])
            first = t if first is None else first
            if before is not None and t - first > begin:
                driven += math.hypot(x - before[0], y - before[1])
            before = x, y
            if driven >= metres:
                return t - first
    raise Failed(f"{truth}: the drive ends {driven:.1f} m after {begin} s, before {metres} m")


def results_of(odom, view, folder, poses):
    """The result of odom evaluate by model; None for poses that it refuses (not finite)."""
    options = ["--align", view.align, "--frame", view.frame]
    if view.begin is not None:
        options += ["--from", f"+{view.begin:g}"]
    if view.metres is not None:
        options += ["--to", f"+{seconds_to_metres(folder / 'truth.csv', view.begin, view.metres):.3f}"]
    elif view.end is not None:
        options += ["--to", f"+{view.end:g}"]

    def of(pose):
        try:
            return evaluate(odom, folder, [pose], *options)[0]
        except Failed:
            return None

    try:
        return dict(zip(poses, evaluate(odom, folder, poses.values(), *options)))
    except Failed:
        return {model: of(pose) for model, pose in poses.items()}


def nanoseconds(stamp):
    whole, _, fraction = stamp.partition(".")
    return int(whole) * 10**9 + int(fraction.ljust(9, "0"))


def decimal(ns, like):
    """`ns` in seconds, with as many decimals as the stamp `like`."""
    return f"{ns // 10**9}.{ns % 10**9:09d}"[: len(like)]


def write_shifted(folder, shifted):
    """Copies the drive of a folder to another, with all stamps a microsecond later. Returns the ticks [ns] that
    a frame or camera pose now comes too late for: there the models know less than before the shift."""
    crossed = set()

    def later(stamp):
        before = nanoseconds(stamp)
        after = before + SHIFT_NS
        if -(-before // PERIOD_NS) != -(-after // PERIOD_NS):
            crossed.add(-(-before // PERIOD_NS) * PERIOD_NS)
        return decimal(after, stamp)

    shifted.mkdir()
    for name in ("car.toml", "car.dbc"):
        (shifted / name).write_text((folder / name).read_text())
    with open(folder / "drive.log") as log, open(shifted / "drive.log", "w") as out:
        for line in log:
            stamp, rest = line[1:].split(")", 1)
            out.write(f"({later(stamp)}){rest}")
    with open(folder / "camera.csv") as camera, open(shifted / "camera.csv", "w") as out:
        out.write(camera.readline())
        for line in camera:
            arrival, capture, rest = line.split(",", 2)
            out.write(f"{later(arrival)},{decimal(nanoseconds(capture) + SHIFT_NS, capture)},{rest}")
    return crossed


def read_poses(file):
    with open(file, newline="") as lines:
        return {nanoseconds(row[0]): (float(row[1]), float(row[2])) for row in list(csv.reader(lines))[1:]}


def replayed(odom, model, folder, poses, camera):
    return replay(odom, folder / "car.toml", folder, poses, "--model", model,
                  *(("--camera", folder / "camera.csv") if camera else ()))


def shift_change(odom, model, folder, poses, shifted):
    """The largest distance [m] between the poses of a tick with and without a shift of all stamps by a
    microsecond: over the ticks that know the same frames and camera poses, and over all ticks."""
    crossed = write_shifted(folder, shifted)
    replayed(odom, model, shifted, shifted / "pose.csv", camera=True)
    here, there = read_poses(poses), read_poses(shifted / "pose.csv")
    change = {t: math.dist(here[t], there[t]) for t in here.keys() & there.keys()}
    return {"largest": max(value for t, value in change.items() if t not in crossed),
            "largest_of_all": max(change.values()), "crossed": len(crossed & change.keys())}


def measure(odom, course, models, folder, scratch):
    """Returns a drive's results: "views" has those of odom evaluate by view and model; "replay" those of the replay by
    model (with the camera, if there are two); "shift", if the course asks for it, the effect on the last model."""
    judged = models[-1]
    result = {"replay": {}, "views": {}}
    for camera in (False, True):
        views = {name: view for name, view in course.views.items() if view.camera == camera}
        poses = {model: scratch / f"{model}-{camera}.csv" for model in models
                 if any(view.compared or model == judged for view in views.values())}
        result["replay"] |= {model: replayed(odom, model, folder, file, camera) for model, file in poses.items()}
        result["views"] |= {name: results_of(odom, view, folder, poses) for name, view in views.items()}
    if course.shift:
        result["shift"] = shift_change(odom, judged, folder, poses[judged], scratch / "shifted")
    return result
