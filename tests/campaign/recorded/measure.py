"""The recorded drives, which part of each is for training and which for evaluation, and a model's errors there."""

import csv
import json
import math
import os
import pathlib
import tempfile
import tomllib
from typing import Any, NamedTuple

import common
from common import ROOT, Failed, output

CONFIGS = ROOT / "tests/data/drives"
LOG = ROOT / "docs/dev/judged.md"
MODELS = ["kinematic", "kinematic_printed", "paper", "inertial", "full"]


class Part(NamedTuple):
    """A drive, or the part of it for `odom evaluate`."""

    drive: str
    what: str = ""  # "": the whole drive
    options: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return f"{self.drive}, {self.what}" if self.what else self.drive


# Only these may be used to tune constants.
TRAINING = [
    Part("dart_free1"),
    Part("dart_slow_steerid"),
    Part("ini_2026_01_16_01_22_28"),
    Part("genesis_slow", "first half", ("--to", "+180.575")),
    Part("rav4", "first 20 s", ("--to", "+20")),
    Part("revs_250lm", "first half", ("--to", "+275")),
    Part("cpm_ucar"),
    Part("f110_ds3"),
    Part("xray_duck_1"),
]
JUDGED = [
    Part("dart_circles1"),
    Part("dart_free2"),
    Part("dart_tire1"),
    Part("ini_2025_12_17_07_40_02"),
    Part("ini_2026_01_16_01_45_24"),
    Part("genesis_slow", "second half", ("--from", "+180.575")),
    Part("rav4", "after 20 s", ("--from", "+20")),
    Part("revs_250lm", "second half", ("--from", "+275")),
]
# The complete drives that are split above.
WHOLE = [Part("genesis_slow", "whole"), Part("rav4", "whole"), Part("revs_250lm", "whole")]
# In one the wheels spin, in the other the reference loses the car: shown, but not part of a
# verdict.
APART = [Part("dart_drift1"), Part("dart_track_v1")]

# Drives whose position is an integral of the true velocity.
VELOCITIES_ONLY = {"revs_250lm", "xray_duck_1"}

# Figures of a model on a part, in the unit that the column's name gives; "" without a figure.
COLUMNS = ["heading_rms_deg", "position_rms_m", "error_35ms_mm", "vx_rms", "vy_rms",
           "camera_position_rms_m", "camera_nees"]
CELLS = COLUMNS[:3]

Figures = dict[str, float]


class Row(NamedTuple):
    part: Part
    model: str
    figures: Figures
    remark: str


def folder_of(drive: str) -> pathlib.Path:
    """The drive's folder, in one of those that ODOMD_DRIVES names."""
    listed = os.environ.get("ODOMD_DRIVES", "")
    places = [pathlib.Path(place).resolve() for place in listed.split(":") if place]
    for place in places:
        if not place.is_dir():
            raise Failed(f"ODOMD_DRIVES: {place} is not a folder")
    for place in places:
        if (place / drive).is_dir():
            return place / drive
    raise Failed(f"ODOMD_DRIVES: no folder {drive} in {listed}")


def config_of(folder: pathlib.Path) -> pathlib.Path:
    own = folder / "car.toml"
    return own if own.exists() else CONFIGS / f"{folder.name.split('_')[0]}.toml"


def lever_arm(config: pathlib.Path) -> str:
    with config.open("rb") as file:
        tables = tomllib.load(file)
    arm = {**tables.get("camera", {}), **tables.get("reference", {})}.get("lever_arm", [0, 0, 0])
    return ",".join(map(str, arm))


def first_pose(truth: pathlib.Path) -> str:
    with truth.open() as file:
        row = next(csv.DictReader(file))
    return ",".join(row[column] for column in ("x", "y", "yaw"))


def stopped_after(poses: pathlib.Path) -> str:
    """When the model left its domain, as the paper's does in reverse; empty if it did not."""
    with poses.open() as file:
        begin = None
        for row in csv.DictReader(file):
            begin = float(row["t"]) if begin is None else begin
            if row["mode"] == "fault":
                return f"stopped after {float(row['t']) - begin:.0f} s: the car reverses"
    return ""


def replay(odom: pathlib.Path, config: pathlib.Path, folder: pathlib.Path, out: pathlib.Path, *options: object) -> None:
    output(odom, "replay", "--config", config, "--dbc", folder / "car.dbc", "--can", folder / "drive.log", "--out", out,
           *options)


def errors(odom: pathlib.Path, folder: pathlib.Path, poses: pathlib.Path, align: str, *options: str) -> dict[str, Any]:
    """What odom evaluate says of these poses."""
    text = output(odom, "evaluate", "--reference", folder / "truth.csv", "--pose", poses, "--align", align, "--json",
                  *options)
    found: dict[str, Any] = json.loads(text)["estimates"][0]
    return found


def dead_reckoning(odom: pathlib.Path, config: pathlib.Path, folder: pathlib.Path, work: pathlib.Path,
                   *options: str) -> dict[str, Any]:
    """The errors of full from the reference's first pose, with these options of odom evaluate."""
    poses = work / "pose.csv"
    replay(odom, config, folder, poses, "--model", "full", f"--initial={first_pose(folder / 'truth.csv')}")
    return errors(odom, folder, poses, "first", *options)


class Replays(NamedTuple):
    """The pose files of one drive through one model: by dead reckoning, and with the camera."""

    alone: pathlib.Path
    with_camera: pathlib.Path | None


def replays(odom: pathlib.Path, folder: pathlib.Path, model: str, work: pathlib.Path) -> Replays:
    config, alone = config_of(folder), work / "alone.csv"
    replay(odom, config, folder, alone, "--model", model, f"--initial={first_pose(folder / 'truth.csv')}")
    if folder.name in VELOCITIES_ONLY or not (folder / "camera.csv").exists():
        return Replays(alone, None)
    with_camera = work / "camera.csv"
    replay(odom, config, folder, with_camera, "--model", model, "--camera", folder / "camera.csv")
    return Replays(alone, with_camera)


def figures_of(odom: pathlib.Path, folder: pathlib.Path, part: Part, poses: Replays) -> Figures:
    options = f"--lever-arm={lever_arm(config_of(folder))}", *part.options
    alone = errors(odom, folder, poses.alone, "first", *options)
    figures = {"error_35ms_mm": 1e3 * alone["error_35ms"]["position"]["mean"]}
    if folder.name in VELOCITIES_ONLY:
        velocity = alone["velocity_rms"]
        return {**figures, "vx_rms": velocity["vx"], "vy_rms": velocity["vy"]}
    figures["heading_rms_deg"] = math.degrees(alone["heading"]["rms"])
    figures["position_rms_m"] = alone["position"]["rms"]
    if poses.with_camera:
        seen = errors(odom, folder, poses.with_camera, "none", *options)
        figures["camera_position_rms_m"] = seen["position"]["rms"]
        if "nees" in seen:
            figures["camera_nees"] = seen["nees"]["mean"]
    return figures


def rows_of(odom: pathlib.Path, folder: pathlib.Path, model: str, parts: list[Part]) -> list[Row]:
    with tempfile.TemporaryDirectory(prefix="drives-") as scratch, common.named(f"{folder.name}, {model}"):
        poses = replays(odom, folder, model, pathlib.Path(scratch))
        remark = stopped_after(poses.alone)
        return [Row(part, model, figures_of(odom, folder, part, poses), remark) for part in parts]


def measure(odom: pathlib.Path, parts: list[Part], models: list[str], jobs: int) -> list[Row]:
    """The rows in the order of the parts, then of the models. Each model replays a drive once, for all its parts."""
    of_drive: dict[str, list[Part]] = {}
    for part in parts:
        of_drive.setdefault(part.drive, []).append(part)
    tasks = [(odom, folder_of(drive), model, own) for drive, own in of_drive.items() for model in models]
    found = [row for rows in common.side_by_side(jobs, rows_of, tasks) for row in rows]
    return sorted(found, key=lambda row: (parts.index(row.part), models.index(row.model)))
