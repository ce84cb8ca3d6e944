"""The recorded drives, which part of each is for training and which for evaluation, and a model's errors there."""

import csv
import math
import os
import pathlib
import tomllib
from typing import Any, NamedTuple

import common
from common import ROOT, Failed

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

# Figures of a model on a part, in the unit that the column's name gives: their headers and digits in tables.
COLUMNS = {"heading_rms_deg": ("heading rms [°]", 1), "position_rms_m": ("position rms [m]", 2),
           "error_35ms_mm": ("35 ms mean [mm]", 2), "vx_rms": ("v_x rms [m/s]", 3), "vy_rms": ("v_y rms [m/s]", 3),
           "camera_position_rms_m": ("position rms with camera [m]", 3), "camera_nees": ("NEES with camera", 1)}
CELLS = {"heading_rms_deg": "heading", "position_rms_m": "position", "error_35ms_mm": "35 ms"}  # for the verdict

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


def replay_alone(odom: pathlib.Path, config: pathlib.Path, folder: pathlib.Path, model: str,
                 poses: pathlib.Path) -> None:
    """By dead reckoning from the reference's first pose."""
    common.replay(odom, config, folder, poses, "--model", model, f"--initial={first_pose(folder / 'truth.csv')}")


def dead_reckoning(odom: pathlib.Path, config: pathlib.Path, folder: pathlib.Path, work: pathlib.Path,
                   *options: str) -> dict[str, Any]:
    """The errors of full from the reference's first pose, with these options of odom evaluate."""
    replay_alone(odom, config, folder, "full", work / "pose.csv")
    return common.evaluate(odom, folder, [work / "pose.csv"], "--align", "first", *options)[0]


def figures_alone(found: dict[str, Any], velocities_only: bool) -> Figures:
    figures = {"error_35ms_mm": 1e3 * found["error_35ms"]["position"]["mean"]}
    if velocities_only:
        return {**figures, "vx_rms": found["velocity_rms"]["vx"], "vy_rms": found["velocity_rms"]["vy"]}
    return {**figures, "heading_rms_deg": math.degrees(found["heading"]["rms"]),
            "position_rms_m": found["position"]["rms"]}


def figures_with_camera(found: dict[str, Any]) -> Figures:
    figures = {"camera_position_rms_m": found["position"]["rms"]}
    return {**figures, "camera_nees": found["nees"]["mean"]} if "nees" in found else figures


def rows_of(odom: pathlib.Path, folder: pathlib.Path, model: str, parts: list[Part]) -> list[Row]:
    """Replays the drive once, for all its parts."""
    config, camera, velocities_only = config_of(folder), folder / "camera.csv", folder.name in VELOCITIES_ONLY
    with common.scratch() as work, common.named(f"{folder.name}, {model}"):
        alone, seen = work / "alone.csv", work / "camera.csv"
        replay_alone(odom, config, folder, model, alone)
        if camera.exists() and not velocities_only:
            common.replay(odom, config, folder, seen, "--model", model, "--camera", camera)
        rows = []
        for part in parts:
            options = f"--lever-arm={lever_arm(config)}", *part.options
            found = common.evaluate(odom, folder, [alone], "--align", "first", *options)
            figures = figures_alone(found[0], velocities_only)
            if seen.exists():
                found = common.evaluate(odom, folder, [seen], "--align", "none", *options)
                figures |= figures_with_camera(found[0])
            rows.append(Row(part, model, figures, stopped_after(alone)))
        return rows


def measure(odom: pathlib.Path, parts: list[Part], models: list[str], jobs: int) -> list[Row]:
    """The rows in the order of the parts, then of the models."""
    of_drive: dict[str, list[Part]] = {}
    for part in parts:
        of_drive.setdefault(part.drive, []).append(part)
    tasks = [(odom, folder_of(drive), model, own) for drive, own in of_drive.items() for model in models]
    found = [row for rows in common.side_by_side(jobs, rows_of, tasks) for row in rows]
    return sorted(found, key=lambda row: (parts.index(row.part), models.index(row.model)))
