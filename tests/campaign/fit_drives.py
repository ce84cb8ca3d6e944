#!/usr/bin/env python3
"""The gain of `odom identify fit` on recorded drives: fitted on one, evaluated on others.

  ODOMD_DRIVES=DIRECTORIES tests/campaign/fit_drives.py [dart] [genesis]

The published parameters of each car (mass, axles, inertia, stiffnesses, age of the gyro; the sensors as they are
delivered) are the start of a fit on one drive with its camera's poses, as anybody would do it; what the fit writes
is judged. Other drives (or the rest of that one) are then replayed by dead reckoning and compared with their
references. Rows: as published; as published, but with the reference's lever arm from the fit, to exclude the error
of the point that is compared; by hand, with tests/data/drives: the scales and offsets of the sensors by somebody
who knew the references of all these drives; as fitted. The table is Markdown; docs/dev/results.md has the figures
that matter. Exit status 1 if, on any drive, a fit does not lower the 35 ms error, the end error and the position's
rms of the published parameters.
"""
import os
import pathlib
import re
import shutil
import sys
import time
from collections.abc import Iterator
from typing import Any

import common
from common import DEGREES, ROOT, output
from recorded import measure

# Car, drive for the fit, its length [s], and the drives to evaluate with their options. In
# dart_track_v1 the reference follows the car only after 17.6 s: before, it jumps by 7 m and
# faces backwards.
CASES = [
    ("dart", "dart_free1", 68.0,
     [("dart_free2", []), ("dart_track_v1", []), ("dart_track_v1", ["--from", "+18"])]),
    ("genesis", "genesis_slow", 180.0, [("genesis_slow", ["--from", "+180"])]),
]


def as_delivered(by_hand: pathlib.Path, published: pathlib.Path) -> None:
    """Writes the configuration by hand without the scales and offsets of the sensors that measure motion."""
    lines = [re.sub(r", (scale|offset) = [-0-9.e]+", "", line)
             if re.match(r"(yaw_rate|accel_x|accel_y|wheel_rear)\s*=", line) else line
             for line in by_hand.read_text().splitlines()]
    published.write_text("\n".join(lines) + "\n")


def fit(odom: pathlib.Path, published: pathlib.Path, folder: pathlib.Path, until: float, fitted: pathlib.Path) -> None:
    shutil.copy(published, fitted)
    begun = time.monotonic()
    sys.stderr.write(output(odom, "identify", "fit", "--config", published, "--dbc", folder / "car.dbc",
                            "--drive", folder, "--quiet", "--to", until, "--write", fitted))
    print(f"fit_drives: {folder.name}: {time.monotonic() - begun:.0f} s", file=sys.stderr)


def judge(odom: pathlib.Path, car: str, taught: str, until: float, others: Any, work: pathlib.Path) -> Iterator[str]:
    """Prints a row for each configuration on each other drive; yields the errors that the fit does not lower."""
    by_hand = ROOT / f"tests/data/drives/{car}.toml"
    published, fitted = work / "published.toml", work / "fitted.toml"
    as_delivered(by_hand, published)
    fit(odom, published, measure.folder_of(taught), until, fitted)
    arm, own = measure.lever_arm(fitted), measure.lever_arm(published)
    rows = [("published", published, own), ("published, arm of the fit", published, arm),
            ("by hand", by_hand, own), ("by hand, arm of the fit", by_hand, arm), ("fitted", fitted, arm)]
    for other, options in others:
        name = " ".join([other, *options])
        figures = []
        for label, config, lever in rows:
            if label.endswith("arm of the fit") and lever == own:
                continue
            e = measure.dead_reckoning(odom, config, measure.folder_of(other), work, f"--lever-arm={lever}", *options)
            figures.append((e["error_35ms"]["position"]["mean"], e["end_error"], e["position"]["rms"]))
            print(f"| {taught} to {until:g} s | {name} | {label} | {e['end_error']:.2f} | "
                  f"{e['end_error_cm_per_m']:.2f} | {e['heading']['end'] * DEGREES:.1f} | {e['position']['rms']:.2f} | "
                  f"{e['error_35ms']['position']['mean'] * 1e3:.2f} |", flush=True)
        for what, before, after in zip(("35 ms", "end", "position"), figures[0], figures[-1]):
            if not after < before:
                yield f"{what} on {name}"


def main() -> int:
    parser = common.parser(__doc__ or "", jobs=False)
    parser.add_argument("cars", nargs="*", default=[car for car, *_ in CASES], metavar="CAR", help="default: all")
    given = common.parse(parser)
    if not os.environ.get("ODOMD_DRIVES"):
        sys.exit("fit_drives: set ODOMD_DRIVES to the folders of recorded drives")
    print(f"Fitted parameters, {common.BEGUN:%F}:\n")
    print("| fitted on | judged on | parameters | end [m] | cm/m | heading end [°] "
          "| position rms [m] | 35 ms mean [mm] |")
    print("|---|---|---|--:|--:|--:|--:|--:|")
    worse = []
    for case in CASES:
        if case[0] in given.cars:
            with common.scratch() as work:
                worse += judge(given.odom, *case, work)
    for what in worse:
        print(f"fit_drives: not lowered: {what}", file=sys.stderr)
    return 1 if worse else 0


if __name__ == "__main__":
    common.main(main)
