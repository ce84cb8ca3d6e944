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
import math
import pathlib
import tempfile
import tomllib
from typing import Any, NamedTuple

import common
from recorded import log, measure

MOST_WORSE = 1.10
COURSES = {"lap": ["--scenario", "lap", "--laps", "3"], "road": ["--scenario", "road", "--duration", "60"],
           "parking": ["--scenario", "parking", "--duration", "40"]}
KNOWN = {"message", "signal", "sum", "unit", "valid_when"}

Table = dict[str, Any]


class Found(NamedTuple):
    """What the drives show so far."""

    ratios: list[tuple[str, str, float]]  # drive, error, with init / by hand
    other_roles: list[tuple[str, str, bool]]  # drive, role, whether it was sure

    def drives(self) -> list[str]:
        return [drive for drive, *_ in self.other_roles + self.ratios]

    def good(self) -> bool:
        return (all(ratio <= MOST_WORSE for _, _, ratio in self.ratios)
                and not any(sure for _, _, sure in self.other_roles))

    def headline(self) -> str:
        ranges = []
        for name in dict.fromkeys(name for _, name, _ in self.ratios):
            some = [ratio for _, other, ratio in self.ratios if other == name]
            ranges.append(f"{name} {min(some):.2f} to {max(some):.2f}")
        worse = [f"{drive} {name} {ratio:.2f}" for drive, name, ratio in self.ratios if ratio > MOST_WORSE]
        roles = [f"{drive} {role} ({'SURE' if sure else 'unsure'})" for drive, role, sure in self.other_roles]
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
    figures = {"error_35ms [mm]": 1e3 * found["error_35ms"]["position"]["mean"]}
    if folder.name in measure.VELOCITIES_ONLY:
        return figures
    return {"heading [deg]": math.degrees(found["heading"]["rms"]), "position [m]": found["position"]["rms"], **figures}


def is_same_role(by_hand: Table, found: Table) -> bool:
    named = by_hand["sum"] if "sum" in by_hand else [by_hand.get("signal")]
    return bool(by_hand.get("message") == found["message"] and named == found["signals"])


def compare(odom: pathlib.Path, folder: pathlib.Path, part: measure.Part, recorded: bool, seen: Found) -> None:
    with tempfile.TemporaryDirectory(prefix="init-") as scratch:
        work = pathlib.Path(scratch)
        by_hand, config, options = folder / "car.toml", work / "init.toml", list(part.options)
        if recorded:
            tested, by_hand = measure.config_of(folder), work / "hand.toml"
            write_by_hand(tested, folder, by_hand)
            options.insert(0, f"--lever-arm={measure.lever_arm(tested)}")
        hand = tomllib.loads(by_hand.read_text())
        vehicle, signals = hand["vehicle"], hand["can"]["signals"]
        car: list[object] = ["--mass", vehicle["mass"], "--front-axle", vehicle["front_axle"], "--wheelbase",
                             vehicle["front_axle"] + vehicle["rear_axle"], "--track", vehicle["track_width"]]
        proposal = json.loads(common.output(odom, "init", "--json", "--dbc", folder / "car.dbc",
                                            "--can", folder / "drive.log", *car, "--out", config, "--force"))
        found = {role["role"]: role for role in proposal["roles"]}
        for role in sorted(set(signals) | set(found)):
            if role not in found:
                print(f"{part.name}: {role} is not proposed", flush=True)
            elif role not in signals:
                print(f"{part.name}: {role} is proposed too", flush=True)
            elif not is_same_role(signals[role], found[role]):
                seen.other_roles.append((part.name, role, found[role]["sure"]))
                print(f"{part.name}: {role} = {found[role]['message']}.{'+'.join(found[role]['signals'])}, "
                      f"{'SURE' if found[role]['sure'] else 'unsure'}", flush=True)
        with_hand, with_init = (errors(odom, one, folder, work, options) for one in (by_hand, config))
        for name, before in with_hand.items():
            ratio = with_init[name] / before
            seen.ratios.append((part.name, name, ratio))
            print(f"| {part.name} | {name} | {before:.4g} | {with_init[name]:.4g} | {ratio:.2f} |", flush=True)


def main() -> int:
    seen = Found([], [])
    return log.look(__doc__ or "", "| drive | error | by hand | init | ratio |\n|---|---|--:|--:|--:|",
                    2, measure.JUDGED, COURSES, seen, lambda *drive: compare(*drive, seen))


if __name__ == "__main__":
    common.main(main)
