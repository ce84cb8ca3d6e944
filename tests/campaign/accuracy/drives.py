"""Simulates a drive, replays it through the models and evaluates what comes out."""

import csv
import json
import math

from common import Failed, last_line, run

SHIFT_NS = 1000  # added to all stamps
PERIOD_NS = 5_000_000  # period of the tick grid


def simulate(odom, course, seed, folder):
    """An existing drive in the folder is reused if its command was the same."""
    command = [odom, "sim", *course.options, "--seed", seed]
    text = " ".join(str(word) for word in command[1:]) + "\n"
    made_by = folder / "command"
    if made_by.exists() and made_by.read_text() == text:
        return
    folder.mkdir(parents=True, exist_ok=True)
    made_by.unlink(missing_ok=True)
    run(*command, "--out", folder, "--force")
    made_by.write_text(text)


def replay(odom, course, model, folder, pose):
    """What the replay reports, as JSON."""
    camera = ["--camera", folder / "camera.csv"] if course.camera else []
    done = run(odom, "replay", "--config", folder / "car.toml", "--can", folder / "drive.log", *camera,
               "--model", model, "--out", pose, "--json")
    return json.loads(last_line(done.stderr))


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


def evaluate(odom, view, folder, poses):
    """The result of odom evaluate by model; None if it refuses the poses (not finite)."""
    options = ["--align", view.align, "--frame", view.frame]
    if view.begin is not None:
        options += ["--from", f"+{view.begin:g}"]
    if view.metres is not None:
        options += ["--to", f"+{seconds_to_metres(folder / 'truth.csv', view.begin, view.metres):.3f}"]
    elif view.end is not None:
        options += ["--to", f"+{view.end:g}"]

    def of(files):
        words = [word for file in files for word in ("--pose", file)]
        done = run(odom, "evaluate", "--reference", folder / "truth.csv", *words, *options, "--json")
        return json.loads(done.stdout)["estimates"]

    try:
        return dict(zip(poses, of(poses.values())))
    except Failed:
        results = {}
        for model, pose in poses.items():
            try:
                results[model] = of([pose])[0]
            except Failed:
                results[model] = None
        return results


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


def shift_change(odom, course, model, folder, pose, shifted):
    """The largest distance [m] between the poses of a tick with and without a shift of all stamps by a
    microsecond: over the ticks that know the same frames and camera poses, and over all ticks."""
    crossed = write_shifted(folder, shifted)
    replay(odom, course, model, shifted, shifted / "pose.csv")
    here, there = read_poses(pose), read_poses(shifted / "pose.csv")
    change = {t: math.dist(here[t], there[t]) for t in here.keys() & there.keys()}
    return {"largest": max(value for t, value in change.items() if t not in crossed),
            "largest_of_all": max(change.values()), "crossed": len(crossed & change.keys())}


def measure(odom, course, seed, models, folder, scratch):
    """A drive's results: by view and model, those of odom evaluate; by model, those of the replay; and, if the
    course asks for it, the effect of the shift of the stamps on the last model."""
    simulate(odom, course, seed, folder)
    poses = {model: scratch / f"{model}.csv" for model in models}
    result = {"course": course.name, "seed": seed}
    result["replay"] = {model: replay(odom, course, model, folder, poses[model]) for model in models}
    result["views"] = {name: evaluate(odom, view, folder, poses) for name, view in course.views.items()}
    if course.shift:
        judged = models[-1]
        result["shift"] = shift_change(odom, course, judged, folder, poses[judged], scratch / "shifted")
    return result
