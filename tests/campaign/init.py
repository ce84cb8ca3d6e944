#!/usr/bin/env python3
"""What `odom init` writes, compared with a configuration written by hand: the errors of dead reckoning with each.

  tests/campaign/init.py                                      simulated drives
  ODOMD_DRIVES=DIRECTORIES tests/campaign/init.py --training  recorded training drives
  ODOMD_DRIVES=DIRECTORIES tests/campaign/init.py --judged    the others; logs the look in docs/dev/judged.md

The one by hand has what the owner knows before any identification: the signals with their signs, units and ratios, and
what is published of the car (with fitted tyre stiffnesses if none are). Nothing else is fitted: no offset, latency,
sigma, or scale within 10 % of 1. For a simulated drive it is the car.toml of `odom sim`. Exit status 1 where an error
with init's file is more than 10 % larger, or a role differs and is not marked as unsure.
"""

import json
import pathlib
import tomllib
from collections.abc import Iterator
from typing import Any

import common
from recorded import log, measure

MOST_WORSE = 1.10
COURSES = {"lap": ["--scenario", "lap", "--laps", "3"], "road": ["--scenario", "road", "--duration", "60"],
           "parking": ["--scenario", "parking", "--duration", "40"]}
ERRORS = {"heading_rms_deg": "heading [deg]", "position_rms_m": "position [m]", "error_35ms_mm": "error_35ms [mm]"}
KNOWN = {"message", "signal", "sum", "unit", "valid_when"}

Table = dict[str, Any]


def headline(lines: list[log.Line]) -> str:
    errors = [line for line in lines if "ratio" in line]
    by_name: dict[str, list[float]] = {}
    for error in errors:
        by_name.setdefault(error["name"], []).append(error["ratio"])
    ranges = [f"{name} {min(some):.2f} to {max(some):.2f}" for name, some in by_name.items()]
    worse = [f"{error['drive']} {error['name']} {error['ratio']:.2f}" for error in errors if error["bad"]]
    roles = [f"{line['drive']} {line['other_role']}" for line in lines if "other_role" in line]
    return (f"init / by hand: {', '.join(ranges) or 'none'}; above {MOST_WORSE}: {', '.join(worse) or 'none'}; "
            f"other roles: {', '.join(roles) or 'none'}")


def toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(one)}" for key, one in value.items()) + " }"
    return json.dumps(value)


def write_by_hand(config: pathlib.Path, folder: pathlib.Path, out: pathlib.Path) -> None:
    """The tested configuration without what was fitted to drives."""
    fitted = tomllib.loads(config.read_text())
    lines = ["[vehicle]", *(f"{key} = {toml(value)}" for key, value in fitted["vehicle"].items()),
             "[can]", f'source = "{folder / "drive.log"}"', f'dbc = "{folder / "car.dbc"}"', "[can.signals]"]
    for role, signal in fitted["can"]["signals"].items():
        known = {key: value for key, value in signal.items() if key in KNOWN}
        if abs(signal.get("scale", 1.0) - 1.0) > 0.1:
            known["scale"] = signal["scale"]
        lines.append(f"{role} = {toml(known)}")
    out.write_text("\n".join(lines) + "\n")


def errors(odom: pathlib.Path, config: pathlib.Path, folder: pathlib.Path, work: pathlib.Path,
           options: list[str]) -> measure.Figures:
    found = measure.dead_reckoning(odom, config, folder, work, *options)
    figures = measure.figures_alone(found, folder.name in measure.VELOCITIES_ONLY)
    return {name: figures[key] for key, name in ERRORS.items() if key in figures}


def is_same_role(by_hand: Table, found: Table) -> bool:
    named = by_hand["sum"] if "sum" in by_hand else [by_hand.get("signal")]
    return bool(by_hand.get("message") == found["message"] and named == found["signals"])


def compare_roles(drive: str, by_hand: Table, found: Table) -> Iterator[log.Line]:
    for role in sorted(set(by_hand) | set(found)):
        if role not in found or role not in by_hand:
            what = "is not proposed" if role not in found else "is proposed too"
            yield {"drive": drive, "bad": False, "text": f"{drive}: {role} {what}"}
        elif not is_same_role(by_hand[role], found[role]):
            its, sure = found[role], "SURE" if found[role]["sure"] else "unsure"
            yield {"drive": drive, "other_role": f"{role} ({sure})", "bad": its["sure"],
                   "text": f"{drive}: {role} = {its['message']}.{'+'.join(its['signals'])}, {sure}"}


def compare_errors(drive: str, by_hand: measure.Figures, found: measure.Figures) -> Iterator[log.Line]:
    for name, before in by_hand.items():
        ratio = found[name] / before
        yield {"drive": drive, "name": name, "ratio": ratio, "bad": not ratio <= MOST_WORSE,  # also for NaN
               "text": f"| {drive} | {name} | {before:.4g} | {found[name]:.4g} | {ratio:.2f} |"}


def compare(odom: pathlib.Path, folder: pathlib.Path, part: measure.Part, recorded: bool) -> Iterator[log.Line]:
    with common.scratch() as work:
        by_hand, config, options = folder / "car.toml", work / "init.toml", list(part.options)
        if recorded:
            tested, by_hand = measure.config_of(folder), work / "hand.toml"
            write_by_hand(tested, folder, by_hand)
            options.insert(0, f"--lever-arm={measure.lever_arm(tested)}")
        hand = tomllib.loads(by_hand.read_text())
        vehicle = hand["vehicle"]
        car: list[object] = ["--mass", vehicle["mass"], "--front-axle", vehicle["front_axle"], "--wheelbase",
                             vehicle["front_axle"] + vehicle["rear_axle"], "--track", vehicle["track_width"]]
        proposal = json.loads(common.output(odom, "init", "--json", "--dbc", folder / "car.dbc",
                                            "--can", folder / "drive.log", *car, "--out", config, "--force"))
        yield from compare_roles(part.name, hand["can"]["signals"], {role["role"]: role for role in proposal["roles"]})
        yield from compare_errors(part.name, *(errors(odom, one, folder, work, options) for one in (by_hand, config)))


def main() -> int:
    return log.look(__doc__ or "", "| drive | error | by hand | init | ratio |\n|---|---|--:|--:|--:|",
                    2, measure.JUDGED, COURSES, compare, headline)


if __name__ == "__main__":
    common.main(main)
